/* A tape of linear operations on tangents. In a recorded step a tangent is the index of an entry, exact as a number; 0 has none. */
#ifndef TAPE_H
#define TAPE_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    double slope[2];
    int32_t of[2]; /* indices of the tangents that the slopes multiply */
} TapeEntry;

typedef struct {
    TapeEntry *entries;
    int32_t used, room;
    int failed; /* whether memory was lacking */
} Tape;

extern __attribute__((visibility("hidden"))) __thread Tape tape;

/* Make room for more entries; return whether there is memory. */
__attribute__((visibility("hidden"))) int tape_enlarged(void);

/* Record the tangent s a + t b. */
static inline double tape_recorded(double s, double a, double t, double b)
{
    if ((a == 0.0 && b == 0.0) || (tape.used == tape.room && !tape_enlarged())) {
        return 0.0;
    }
    TapeEntry *const entry = &tape.entries[tape.used];
    entry->slope[0] = s;
    entry->slope[1] = t;
    entry->of[0] = (int32_t)a;
    entry->of[1] = (int32_t)b;
    return (double)tape.used++;
}

#endif
