/* Example for {{ name }}: call it once in every cycle of the drive, here {{ rate }} Hz, with the desired motion and the measured position.
   On a target this loop is the interrupt of the cycle, and `measured` reads an encoder. */

#include "{{ name }}.h"

#include <stdio.h>

#define CYCLE {{ dt }} /* [s] */
#define SPEED 1e-3     /* of the desired motion [{{ unit_x }}/s] */

int main(void)
{
    static {{ name }} axis;
    {{ name }}_start(&axis);
    for (unsigned cycle = 0; cycle < 1000U; ++cycle) {
        {{ name }}_inputs inputs = {0};
        inputs.position = SPEED * CYCLE * (double)cycle;
        inputs.velocity = SPEED;
{% for input in inputs if input.name == 'place_ahead' %}        for (unsigned i = 0; i < {{ ahead }}U; ++i) {
            inputs.place_ahead[i] = SPEED * CYCLE * (double)(cycle + 1U + i);
        }
{% endfor %}        inputs.measured = inputs.position; /* an axis that follows exactly */
        const double effort = {{ name }}_effort(&axis, &inputs);
        if (cycle % 100U == 0U) {
            printf("%.4f s  x = %.3e {{ unit_x }}  effort = %.4g {{ unit_force }}\n", cycle * CYCLE, inputs.measured, effort);
        }
    }
    return axis.flags;
}
