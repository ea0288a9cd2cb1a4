/* Example for {{ name }}: call it once in every cycle of the drive, here {{ rate }} Hz, with {% if operator %}its input{% else %}the measured or desired position{% endif %}.
   On a target this loop is the interrupt of the cycle, and `position` reads an encoder. */

#include "{{ name }}.h"

#include <stdio.h>

#define CYCLE {{ dt }} /* [s] */

/* Position of an axis that moves forward and back by {{ amplitude }} {{ unit_x }} in {{ period }} s. */
static double position(unsigned cycle)
{
    const unsigned period = {{ cycles }}U;
    const unsigned at = cycle % period;
    const double share = (double)(at < period / 2U ? at : period - at) / (0.5 * (double)period);
    return {{ amplitude }} * share;
}

int main(void)
{
    static {{ name }} axis;
    {{ name }}_start(&axis);
    for (unsigned cycle = 0; cycle < {{ 2 * cycles }}U; ++cycle) {
        const double x = position(cycle);
{% if operator %}        const double friction = {{ name }}_output(&axis, x);
{% else %}        const double friction = {{ name }}_{% if feed %}feed{% else %}force{% endif %}(&axis, x, CYCLE);
        /* Friction of the motion up to now: add it to the effort of the controller. */
{% endif %}        if (cycle % {{ every }}U == 0U) {
            printf("%.4f s  x = %.3e {{ unit_x }}  {% if operator %}output{% else %}friction{% endif %} = %.4g {{ unit_force }}\n", cycle * CYCLE, x, friction);
        }
    }
    return axis.flags;
}
