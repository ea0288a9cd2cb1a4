/* Counts the instructions of each step along the walk of the self-test, by the timer of the core: the emulator lets one
   instruction take so long that the timer resolves it. Prints all of them and those of the longest step, in ticks. */

#include "walk.h"

#include <stdint.h>
#include <stdio.h>

#define CONTROL (*(volatile uint32_t *)0xE000E010U)
#define RELOAD (*(volatile uint32_t *)0xE000E014U)
#define CURRENT (*(volatile uint32_t *)0xE000E018U)
#define MOST UINT32_C(0xFFFFFF)

static uint32_t elapsed(uint32_t begun)
{
    return (begun - CURRENT) & MOST;
}

int main(void)
{
    static const double scales[] = SCALES;
    static AXIS axis;
    uint32_t bits = SEED, worst = 0, step = 0;
    uint64_t total = 0;
    double x = 0.0;
    RELOAD = MOST;
    CURRENT = 0;
    CONTROL = 5U;
    const uint32_t empty = elapsed(CURRENT);
    START(&axis);
    (void)CALL(&axis, x);
    for (uint32_t k = 1; k < STEPS; ++k) {
        bits = bits * 1664525U + 1013904223U;
        if ((bits >> 8U) % RESTS != 0U) {
            x = x + ((double)(bits >> 16U) - 32768.0) * scales[(k / PART) % (sizeof scales / sizeof *scales)];
        }
        const uint32_t begun = CURRENT;
        (void)CALL(&axis, x);
        const uint32_t taken = elapsed(begun) - empty;
        total += taken;
        step = taken > worst ? k : step;
        worst = taken > worst ? taken : worst;
    }
    printf("%lu %lu %lu\n", (unsigned long)(total / (STEPS - 1U)), (unsigned long)worst, (unsigned long)step);
    return 0;
}
