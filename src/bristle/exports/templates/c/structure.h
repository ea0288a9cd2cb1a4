/* What may be in `flags`; each stays until you clear it. */
#define {{ guard }}_REFUSED 1  /* what came in was no finite number{% if parameters %}, or a parameter left its range{% endif %}: the last output was held */
#define {{ guard }}_OVERFLOW 2 /* what was to go out was no finite number: the last output was held */
{% include "c/parameters.h" %}typedef struct {{ name }} {
    double position; /* last {% if operator %}input{% else %}position{% endif %} taken [{{ unit_x }}] */
    int32_t begun;   /* whether there was one; between both numbers, or some compilers store these as one, together late */
    double force;    /* last {% if operator %}output{% else %}force{% endif %} given [{{ unit_force }}] */
    int32_t flags;   /* {{ guard }}_REFUSED, {{ guard }}_OVERFLOW, or 0 */
{% if state %}    struct {
{% for line in state %}        {{ line }}
{% endfor %}    } state;
{% endif %}{% if memory %}    {{ scalar }} memory[{{ memory }}]; /* what the contact remembers */
{% endif %}{% if parameters %}    {{ name }}_parameters parameters;
{% endif %}} {{ name }};
