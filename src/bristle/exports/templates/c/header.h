/* {{ title }}

   {{ description }}
{% for line in facts %}   {{ line | folded('   ') }}
{% endfor %}
   {% filter folded("   ") %}{% include "c/cost.txt" %}{% endfilter %}

   Written by bristle {{ version }}. Build with {{ flags }}: fused multiply-add changes the last bits of the results,
   and {{ name }}_selftest.c then fails.

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

/* Reset to a virgin contact without a sample. Call it before any other function. */
void {{ name }}_start({{ name }} *axis);

{% if operator %}/* The output [{{ unit_force }}] at the input `x` [{{ unit_x }}], after one move from the last input; the first move begins at 0. */
double {{ name }}_output({{ name }} *axis, double x);
{% else %}/* The mean friction force [{{ unit_force }}] of the step that ends at the position `x` [{{ unit_x }}], `dt` [s] after the last call; positive
   when it opposes a motion to larger `x`. The first call sets the position of the axis, and returns 0. */
double {{ name }}_force({{ name }} *axis, double x, double dt);
{% endif %}{% if signals %}
/* The same force with further inputs: {{ told_signals | join('; ') }}. */
double {{ name }}_force_at({{ name }} *axis, double x, double dt{% for signal in signals %}, double {{ signal }}{% endfor %});
{% endif %}{% if feed %}
/* The effort to feed forward [{{ unit_force }}]: call it in place of `{{ name }}_force`, along the desired motion. The constant and the viscous
   part of the friction are fed whole, the rest with a share. In motion the share returns to the gain. At rest it fades, and the
   integral of the controller takes the load over without a bump. */
double {{ name }}_feed({{ name }} *axis, double x, double dt);
{% endif %}{% if drive %}
/* The same {% if feed %}feed{% else %}force{% endif %} in the units of the drive from the axis file: `position` in {{ drive.position.unit }}, the command in
   {{ drive.efforts[0].unit }}. */
#define {{ guard }}_POSITION_UNIT ({{ drive.position.si }}) /* {{ drive.unit_x }} for 1 {{ drive.position.unit }} */
{% for each in drive.efforts %}#define {{ guard }}_{{ each.macro }} ({{ each.si }}) /* {{ drive.unit_force }} for 1 {{ each.unit }} */
{% endfor %}double {{ name }}_command({{ name }} *axis, double position, double dt);
{% endif %}{% if derived %}{% include "c/derivatives.h" %}{% endif %}
/* Write the state of the contact into {{ guard }}_SAVED bytes, in the same format on every target{% if parameters %}; parameters are not saved{% endif %}. */
void {{ name }}_save(const {{ name }} *axis, unsigned char *bytes);

/* Restore a saved state and return 1. If the bytes are damaged or of another model, return 0 without a change. */
int {{ name }}_load({{ name }} *axis, const unsigned char *bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
