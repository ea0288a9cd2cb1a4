/* Values of `flags`; each stays set until you clear it. */
#define {{ guard }}_REFUSED 1  /* an input was not a finite number{% if parameters %}, or a parameter left its range{% endif %}: the last output was returned */
#define {{ guard }}_OVERFLOW 2 /* the result was not a finite number: the last output was returned */
{% if feed %}/* The share of the friction in `{{ name }}_feed`; define them all before, for other values. */
#ifndef {{ guard }}_GAIN
{% for macro, value, meaning in feed.constants %}#define {{ guard }}_{{ macro }} {{ value }} /* {{ meaning }} */
{% endfor %}#endif
{% endif %}{% include "c/parameters.h" %}typedef struct {{ name }} {
    double position; /* last accepted {% if operator %}input{% else %}position{% endif %} [{{ unit_x }}] */
    int32_t begun;   /* whether there was a sample; placed here, because some compilers store adjacent numbers together, late */
    double force;    /* last {% if operator %}output{% else %}force{% endif %} [{{ unit_force }}] */
    int32_t flags;   /* {{ guard }}_REFUSED, {{ guard }}_OVERFLOW, or 0 */
{% if feed %}    double gain;     /* share of the contact force in `{{ name }}_feed`: {{ guard }}_GAIN, or less while you try it */
    double share;    /* present share, from 0 to the gain */
    double feed;     /* last feed [{{ unit_force }}] */
{% endif %}{% if state %}    struct {
{% for line in state %}        {{ line }}
{% endfor %}    } state;
{% endif %}{% if memory %}    {{ scalar }} memory[{{ memory }}]; /* memory of the contact */
{% endif %}{% if parameters %}    {{ name }}_parameters parameters;
{% endif %}} {{ name }};
