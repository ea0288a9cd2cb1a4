/* {{ title }}, as in the variant {{ variant }}.

   {{ description }}.
   Fed forward: {{ fed | join('; ') }}.
{% for line in facts %}   {{ line }}
{% endfor %}
   Written by bristle {{ version }}. Build with {{ flags }}: a compiler that contracts a product and a sum into one
   operation gives other bits, and {{ name }}_selftest.c says so.

{{ table }}
{% if friction %}
   {{ friction }}, fed forward along the {{ along }} motion:
{{ fed_table }}
{% endif %}
   Sample time {{ dt }} s. Delay from a measurement to the effort computed from it: {{ delay }} sample{{ '' if delay == 1 else 's' }}.{% if limit %} Largest effort
   of the drive: {{ limit }} {{ unit_force }}.{% endif %} */

#ifndef {{ guard }}_H
#define {{ guard }}_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What may be in `flags`; each stays until you clear it. */
#define {{ guard }}_REFUSED 1  /* what came in was no finite number{% if parameters %}, or a parameter left its range{% endif %}: the last effort was held, the sample left out */
#define {{ guard }}_OVERFLOW 2 /* what was to go out was no finite number: the last effort was held; start anew */

/* What the law is told in every cycle. */
typedef struct {
{% for input in inputs %}    double {{ input.declared }}; /* {{ input.told }} [{{ input.unit }}] */
{% endfor %}} {{ name }}_inputs;

{% include "c/parameters.h" %}typedef struct {{ name }} {
    double effort; /* last effort commanded [{{ unit_force }}] */
    int32_t begun; /* whether there was one */
    int32_t flags; /* {{ guard }}_REFUSED, {{ guard }}_OVERFLOW, or 0 */
{% if state %}    struct {
{% for line in state %}        {{ line }}
{% endfor %}    } state;
{% endif %}{% if memory %}    {{ scalar }} memory[{{ memory }}]; /* what the contact of the compensator remembers */
{% endif %}{% if parameters %}    {{ name }}_parameters parameters;
{% endif %}} {{ name }};

/* Bytes that `{{ name }}_save` writes. */
#define {{ guard }}_SAVED {{ saved }}

/* Begin anew. Call it before anything else, and whenever the law takes over: the first cycle then takes over the desired
   motion, with its velocity and acceleration, at the position that is measured. */
void {{ name }}_start({{ name }} *axis);

/* The effort to be commanded [{{ unit_force }}]. Call it once in every cycle, {{ rate }} times a second. */
double {{ name }}_effort({{ name }} *axis, const {{ name }}_inputs *inputs);

{% if drive %}/* The units of the drive, as the axis file describes them, and the same effort in {{ drive.efforts[0].unit }}. */
{% for each in drive.efforts %}#define {{ guard }}_{{ each.macro }} ({{ each.si }}) /* {{ drive.unit_force }} for 1 {{ each.unit }} */
{% endfor %}double {{ name }}_command({{ name }} *axis, const {{ name }}_inputs *inputs);

{% endif %}/* Write what the law keeps from cycle to cycle into {{ guard }}_SAVED bytes, the same on every target{% if parameters %}; parameters are not saved{% endif %}. */
void {{ name }}_save(const {{ name }} *axis, unsigned char *bytes);

/* Go on from what was saved. Return 1; or 0, and change nothing, where the bytes are not those of this law or damaged. */
int {{ name }}_load({{ name }} *axis, const unsigned char *bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
