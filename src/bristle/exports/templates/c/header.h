/* {{ title }}

   {{ description }}
{% for line in facts %}   {{ line }}
{% endfor %}
   Written by bristle {{ version }}. Build with {{ flags }}: a compiler that contracts a product and a sum into one
   operation gives other bits, and {{ name }}_selftest.c says so.

{{ table }} */

#ifndef {{ guard }}_H
#define {{ guard }}_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

{% include "c/structure.h" %}
/* Bytes that `{{ name }}_save` writes. */
#define {{ guard }}_SAVED {{ saved }}

/* Begin anew: a virgin contact, nothing came yet. Call it before anything else. */
void {{ name }}_start({{ name }} *axis);

{% if operator %}/* The output [{{ unit_force }}] at the input `x` [{{ unit_x }}], reached in one move from the last one; the first one from 0. */
double {{ name }}_output({{ name }} *axis, double x);
{% else %}/* The mean friction force [{{ unit_force }}] of the step that ends at the position `x` [{{ unit_x }}], `dt` [s] after the last call; positive
   when it opposes a motion to larger `x`. The first call sets where the axis is, and gives 0. */
double {{ name }}_force({{ name }} *axis, double x, double dt);
{% endif %}{% if signals %}
/* The same with what friction depends on besides: {{ told_signals | join('; ') }}. */
double {{ name }}_force_at({{ name }} *axis, double x, double dt{% for signal in signals %}, double {{ signal }}{% endfor %});
{% endif %}{% if drive %}
/* The units of the drive, as the axis file describes them, and the same force in them: `position` in {{ drive.position.unit }},
   the command in {{ drive.efforts[0].unit }}. */
#define {{ guard }}_POSITION_UNIT ({{ drive.position.si }}) /* {{ drive.unit_x }} for 1 {{ drive.position.unit }} */
{% for each in drive.efforts %}#define {{ guard }}_{{ each.macro }} ({{ each.si }}) /* {{ drive.unit_force }} for 1 {{ each.unit }} */
{% endfor %}double {{ name }}_command({{ name }} *axis, double position, double dt);
{% endif %}
/* Write what the contact remembers into {{ guard }}_SAVED bytes, the same on every target{% if parameters %}; parameters are not saved{% endif %}. */
void {{ name }}_save(const {{ name }} *axis, unsigned char *bytes);

/* Go on from what was saved. Return 1; or 0, and change nothing, where the bytes are not those of this model or damaged. */
int {{ name }}_load({{ name }} *axis, const unsigned char *bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
