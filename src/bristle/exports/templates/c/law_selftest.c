/* Self-test of {{ name }}: a walk of {{ count }} samples that the axis follows one sample late. It compares the {% if tolerance %}efforts with
   those of bristle {{ version }} in Python with double precision.{% else %}hash of the
   efforts with that of bristle {{ version }} in Python: results must be identical.{% endif %} Prints the hash; exit code 0 or 1. */

#include "{{ name }}.h"

#include <stdio.h>

#define COUNT {{ count }}

static double x[{{ positions }}];

{% include "c/hashed.c" %}static double velocity(unsigned k)
{
    return (x[k + 1U] - x[k]) / {{ dt }};
}

int main(void)
{
    static const double scales[{{ scales | length }}] = { {{- scales | join(', ') -}} };
    static {{ name }} axis, copy;
    static unsigned char saved[{{ guard }}_SAVED];
    static {{ name }}_inputs inputs;
{% include "c/expected.c" %}    uint64_t hash = UINT64_C(0xCBF29CE484222325);
    uint32_t bits = {{ seed }}U;
    double effort = 0.0;
    for (unsigned k = 1; k < {{ positions }}U; ++k) {
        x[k] = x[k - 1U];
        bits = bits * {{ factor }}U + {{ term }}U;
        if ((bits >> 8U) % {{ rests }}U != 0U) {
            x[k] = x[k - 1U] + ((double)(bits >> 16U) - 32768.0) * scales[(k / {{ part }}U) % {{ scales | length }}U];
        }
    }
    {{ name }}_start(&axis);
    for (unsigned k = 0; k < COUNT; ++k) {
        inputs.position = x[k];
        inputs.velocity = velocity(k);
        inputs.acceleration = {{ per_velocity }} * velocity(k);
        inputs.measured = x[k > 0U ? k - 1U : 0U];
{% for input in inputs if input.several %}        for (unsigned i = 0; i < {{ ahead }}U; ++i) {
            inputs.{{ input.name }}[i] = {% if input.name == 'place_ahead' %}x[k + 1U + i]{% else %}{{ per_velocity }} * velocity(k + 1U + i){% endif %};
        }
{% endfor %}        effort = {{ name }}_effort(&axis, &inputs);
        hash = hashed(hash, effort);
{% include "c/missed.c" %}        if (k == COUNT / 2U) {
            {{ name }}_save(&axis, saved);
            {{ name }}_start(&copy);
            if (!{{ name }}_load(&copy, saved, sizeof saved)) {
                return fails("the saved state is refused");
            }
        } else if (k > COUNT / 2U && {{ name }}_effort(&copy, &inputs) != effort) {
            return fails("the restored state continues differently");
        }
    }
    printf("{{ name }}: hash %08lx%08lx, last effort %.17g\n", (unsigned long)(hash >> 32U),
           (unsigned long)(hash & UINT64_C(0xFFFFFFFF)), effort);
{% include "c/judged.c" %}    inputs.measured = (x[COUNT] - x[COUNT]) / (x[COUNT] - x[COUNT]);
    if ({{ name }}_effort(&axis, &inputs) != effort || (axis.flags & {{ guard }}_REFUSED) == 0) {
        return fails("a position that is not a number is accepted");
    }
    saved[{{ guard }}_SAVED / 2U] ^= 1U;
    if ({{ name }}_load(&copy, saved, sizeof saved)) {
        return fails("damaged bytes are accepted");
    }
    printf("{{ name }}: {% if tolerance %}matches bristle within single precision{% else %}identical to bristle{% endif %}\n");
    return 0;
}
