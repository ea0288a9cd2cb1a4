/* Counts the instructions of each step along a motion of hard cases, by the timer of the core: the emulator lets one
   instruction take so long that the timer resolves it. Prints their mean and median, and the longest step, in ticks.

   The motion is the walk of the self-test at scales from a thousandth of break-away to thousands of it; after each part
   of the walk it turns more often than a memory has room, in loops that shrink, and two long steps leave all of them. */

#include "walk.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define CONTROL (*(volatile uint32_t *)0xE000E010U)
#define RELOAD (*(volatile uint32_t *)0xE000E014U)
#define CURRENT (*(volatile uint32_t *)0xE000E018U)
#define MOST UINT32_C(0xFFFFFF)
#define LOOPS 260U
#define PERIOD (PART + LOOPS + 2U)

static uint32_t counts[STEPS - 1U];

static uint32_t elapsed(uint32_t begun)
{
    return (begun - CURRENT) & MOST;
}

static int compared(const void *first, const void *second)
{
    const uint32_t a = *(const uint32_t *)first, b = *(const uint32_t *)second;
    return (a > b) - (a < b);
}

static double moved(double x, uint32_t k)
{
    static const double scales[] = SCALES, further[] = {1.0, 1.0, 1.0, 1.0, 1e4, 1e6};
    static uint32_t bits = SEED;
    static double middle, size;
    const uint32_t place = k % PERIOD, part = (k / PERIOD) % 6U;
    const double scale = scales[part % 4U] * further[part];
    bits = bits * 1664525U + 1013904223U;
    if (place < PART) {
        middle = x;
        size = 65536.0 * scale;
        return (bits >> 8U) % RESTS == 0U ? x : x + ((double)(bits >> 16U) - 32768.0) * scale;
    }
    size = place < PART + LOOPS ? 0.98 * size : 2e5 * scale;
    return place % 2U == 0U ? middle + size : middle - size;
}

int main(void)
{
    static AXIS axis;
    uint32_t step = 0;
    uint64_t total = 0;
    double x = 0.0;
    RELOAD = MOST;
    CURRENT = 0;
    CONTROL = 5U;
    const uint32_t empty = elapsed(CURRENT);
    START(&axis);
    (void)CALL(&axis, x);
    for (uint32_t k = 1; k < STEPS; ++k) {
        x = moved(x, k);
        const uint32_t begun = CURRENT;
        (void)CALL(&axis, x);
        counts[k - 1U] = elapsed(begun) - empty;
        total += counts[k - 1U];
        step = counts[k - 1U] > counts[step] ? k - 1U : step;
    }
    const uint32_t worst = counts[step];
    qsort(counts, STEPS - 1U, sizeof *counts, compared);
    printf("%lu %lu %lu %lu\n", (unsigned long)(total / (STEPS - 1U)), (unsigned long)counts[STEPS / 2U], (unsigned long)worst,
           (unsigned long)(step + 1U));
    return 0;
}
