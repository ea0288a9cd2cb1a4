/* {{ title }}. See {{ name }}.h. Written by bristle {{ version }}; do not edit, export again. */

#include "{{ name }}.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

{% include "shared/guards.c" %}{{ helpers }}
{{ definitions }}
{{ data }}
static inline bool is_finite(double x)
{
    return x - x == 0.0;
}

