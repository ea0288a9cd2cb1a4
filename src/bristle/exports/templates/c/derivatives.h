
/* Numbers in `parameters` of a tangent:
{% for line in d_parameters %}   {{ line }}
{% endfor %}*/
#define {{ guard }}_PARAMETERS {{ directions }}

/* A tangent: the change of an axis in one direction. Set `parameters` after `{{ name }}_start_d`; the steps change the rest. */
typedef struct {{ name }}_tangent {
    double position; /* of the last position */
    double force;    /* of the last force */
{% if d_state %}    struct {
{% for field in d_state %}        double {{ field }};
{% endfor %}    } state;
{% endif %}{% if memory %}    double memory[{{ memory }}];
{% endif %}    double parameters[{{ guard }}_PARAMETERS];
} {{ name }}_tangent;

/* Set a tangent to zero. Call it with `{{ name }}_start`. */
void {{ name }}_start_d({{ name }}_tangent *d);

/* One step, with the force of `{{ name }}_force{{ '_at' if signals }}` to the bit, and its change in each of `count` directions, in `d_force`. The axis and
   all `count` tangents advance. `d_x` and the other changes of inputs have `count` numbers; NULL stands for zeros. */
double {{ name }}_force_d({{ name }} *axis, {{ name }}_tangent *d, size_t count, double x, const double *d_x, double dt, const double *d_dt,
{{ '    ' }}{% for signal in signals %}double {{ signal }}, const double *d_{{ signal }}, {% endfor %}double *d_force);
