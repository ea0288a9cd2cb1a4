/* A tape of linear operations on tangents. In a recorded step, the lowest 32 bits of a tangent are the index of an entry; 0 has none. */
#ifndef TAPE_H
#define TAPE_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    double slope[2];
    uint32_t of[2]; /* indices of the tangents that the slopes multiply */
} TapeEntry;

typedef struct {
    TapeEntry *entries;
    uint32_t used, room;
    int failed; /* whether memory was lacking */
} Tape;

extern __attribute__((visibility("hidden"))) Tape tape;

/* Make room for more entries; return whether there is memory. */
__attribute__((visibility("hidden"))) int tape_enlarged(void);

static inline uint32_t tape_index(double tangent)
{
    const union { double number; uint64_t bits; } both = {tangent};
    return (uint32_t)both.bits;
}

/* The tangent with an index: 2 to the 52 plus the index. */
static inline double tape_tangent(uint32_t index)
{
    union { double number; uint64_t bits; } both = {0x1p52};
    both.bits |= index;
    return both.number;
}

/* Record the tangent s a + t b. */
static inline double tape_recorded(double s, double a, double t, double b)
{
    const uint32_t first = tape_index(a), second = tape_index(b);
    if ((first | second) == 0U) {
        return 0.0;
    }
    if (tape.used == tape.room && !tape_enlarged()) {
        return 0.0;
    }
    TapeEntry *const entry = &tape.entries[tape.used];
    entry->slope[0] = s;
    entry->slope[1] = t;
    entry->of[0] = first;
    entry->of[1] = second;
    return tape_tangent(tape.used++);
}

static inline double tape_sum(double a, double b)
{
    return tape_index(a) == 0U ? b : tape_index(b) == 0U ? a : tape_recorded(1.0, a, 1.0, b);
}

static inline double tape_scaled(double s, double a)
{
    return s == 1.0 ? a : tape_recorded(s, a, 0.0, 0.0);
}

#endif
