/* Start of a program on a Cortex-M of the boards MPS2: the vectors, and the floating-point unit switched on. */

#include <stdint.h>

extern void _start(void);
extern uint32_t top_of_stack[];

void reset(void);
static void stopped(void);

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    top_of_stack, reset, stopped, stopped, stopped, stopped, stopped, 0, 0, 0, 0, stopped, stopped, 0, stopped, stopped,
};

void reset(void)
{
    *(volatile uint32_t *)0xE000ED88U |= UINT32_C(0xF) << 20U;
    __asm volatile("dsb\n isb");
    _start();
}

static void stopped(void)
{
    for (;;) {
    }
}

/* What the C library calls before and after `main`. */
void _init(void);
void _fini(void);

void _init(void)
{
}

void _fini(void)
{
}
