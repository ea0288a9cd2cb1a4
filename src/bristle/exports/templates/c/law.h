/* {{ title }}, variant {{ variant }}.

   {{ description }}.
   {{ ('Fed forward: ' ~ (fed | join('; ')) ~ '.') | folded('   ') }}
{% for line in facts %}   {{ line | folded('   ') }}
{% endfor %}
   Written by bristle {{ version }}. Build with {{ flags }}: fused multiply-add changes the last bits of the results,
   and {{ name }}_selftest.c then fails.

{{ table }}
{% for title, rows in frictions.items() %}
   {{ title }}:
{{ rows }}
{% endfor %}
   Sample time {{ dt }} s. Delay from a measurement to the effort computed from it: {{ delay }} sample{{ '' if delay == 1 else 's' }}.{% if limit %} Largest effort
   of the drive: {{ limit }} {{ unit_force }}.{% endif %} */

#ifndef {{ guard }}_H
#define {{ guard }}_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Values of `flags`; each stays set until you clear it. */
#define {{ guard }}_REFUSED 1  /* an input was not a finite number{% if parameters %}, or a parameter left its range{% endif %}: the last effort was returned, the sample skipped */
#define {{ guard }}_OVERFLOW 2 /* the result was not a finite number: the last effort was returned; start again */

/* Inputs of the law in every cycle. */
typedef struct {
{% for input in inputs %}    double {{ input.declared }}; /* {{ input.told }} [{{ input.unit }}] */
{% endfor %}} {{ name }}_inputs;

{% include "c/parameters.h" %}typedef struct {{ name }} {
    double effort; /* last commanded effort [{{ unit_force }}] */
    int32_t begun; /* whether there was a sample */
    int32_t flags; /* {{ guard }}_REFUSED, {{ guard }}_OVERFLOW, or 0 */
{% if state %}    struct {
{% for line in state %}        {{ line }}
{% endfor %}    } state;
{% endif %}{% if memory %}    {{ scalar }} memory[{{ memory }}]; /* memory of the compensator */
{% endif %}{% if parameters %}    {{ name }}_parameters parameters;
{% endif %}} {{ name }};

/* Bytes that `{{ name }}_save` writes. */
#define {{ guard }}_SAVED {{ saved }}

/* Reset the law. Call it before any other function, and whenever the law takes over. The first cycle then starts at the
   measured position, with the velocity and acceleration of the desired motion. */
void {{ name }}_start({{ name }} *axis);

/* The effort to command [{{ unit_force }}]. Call it once in every cycle, {{ rate }} times a second. */
double {{ name }}_effort({{ name }} *axis, const {{ name }}_inputs *inputs);

{% if drive %}/* The units of the drive from the axis file, and the same effort in {{ drive.efforts[0].unit }}. */
{% for each in drive.efforts %}#define {{ guard }}_{{ each.macro }} ({{ each.si }}) /* {{ drive.unit_force }} for 1 {{ each.unit }} */
{% endfor %}double {{ name }}_command({{ name }} *axis, const {{ name }}_inputs *inputs);

{% endif %}/* Write the state of the law into {{ guard }}_SAVED bytes, in the same format on every target{% if parameters %}; parameters are not saved{% endif %}. */
void {{ name }}_save(const {{ name }} *axis, unsigned char *bytes);

/* Restore a saved state and return 1. If the bytes are damaged or of another law, return 0 without a change. */
int {{ name }}_load({{ name }} *axis, const unsigned char *bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
