/* {{ title }}, as external functions of CasADi. Written by bristle {{ version }}; do not edit, export again.

   cc -O2 {{ flags }} -shared -fPIC {{ name }}.c {{ name }}_casadi.c -o {{ name }}.so -lm

   step = casadi.external('{{ name }}_step', './{{ name }}.so'): (state, x, dt, parameters{{ ", " if signals }}{{ signals | join(", ") }}) -> (next state, force)
   initial = casadi.external('{{ name }}_initial', './{{ name }}.so'): () -> (virgin state, exported parameters)

   The first number of the state is the last position: set it to the first position. Parameters have the order of {{ name }}.h.
   First derivatives are exact. Second derivatives do not exist: use an approximation of the Hessian, such as L-BFGS. */

#include "{{ name }}.h"

#ifndef casadi_int
#define casadi_int long long int
#endif
#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED
#endif

enum { STATES = {{ states }}, INPUTS = {{ 4 + signals | length }}, OUTPUTS = 2, LARGEST = {{ [states, directions] | max }} };

static const casadi_int sizes_in[INPUTS][3] = { {STATES, 1, 1}, {1, 1, 1}, {1, 1, 1}, { {{- guard }}_PARAMETERS, 1, 1}{% for signal in signals %}, {1, 1, 1}{% endfor %} };
static const casadi_int sizes_out[OUTPUTS][3] = { {STATES, 1, 1}, {1, 1, 1} };

static double number(const double *values, int i)
{
    return values ? values[i] : 0.0;
}

/* Return 0 if the state is not of this model. */
static int unpacked({{ name }} *axis, const double *s, const double *p)
{
    {{ name }}_start(axis);
    axis->begun = 1;
    axis->position = number(s, 0);
{% for field in fields %}{% if field.capacity %}    if (!(number(s, {{ field.at }}) >= 0.0 && number(s, {{ field.at }}) < {{ field.capacity }}.0)) {
        return 0;
    }
{% endif %}    axis->state.{{ field.name }} = {{ "(" ~ field.type ~ ")" if field.capacity }}number(s, {{ field.at }});
{% endfor %}{% if memory %}    for (int i = 0; i < {{ memory }}; ++i) {
        axis->memory[i] = number(s, {{ 1 + fields | length }} + i);
    }
{% endif %}{% for place in numbers %}    axis->{{ place }} = number(p, {{ loop.index0 }});
{% endfor %}    return 1;
}

static void packed(const {{ name }} *axis, double *s)
{
    s[0] = axis->position;
{% for field in fields %}    s[{{ loop.index }}] = {{ "(double)" if field.capacity }}axis->state.{{ field.name }};
{% endfor %}{% if memory %}    for (int i = 0; i < {{ memory }}; ++i) {
        s[{{ 1 + fields | length }} + i] = axis->memory[i];
    }
{% endif %}}

static int changed(const double **arg, const double **seed, double *d_next, double *d_force)
{
    {{ name }} axis;
    {{ name }}_tangent d;
    const double d_x = number(seed[1], 0), d_dt = number(seed[2], 0);
{% for signal in signals %}    const double d_{{ signal }} = number(seed[{{ 3 + loop.index }}], 0);
{% endfor %}    if (!unpacked(&axis, arg[0], arg[3])) {
        return 1;
    }
    {{ name }}_start_d(&d);
    d.position = number(seed[0], 0);
{% for field in fields if not field.capacity %}    d.state.{{ field.name }} = number(seed[0], {{ field.at }});
{% endfor %}{% if memory %}    for (int i = 0; i < {{ memory }}; ++i) {
        d.memory[i] = number(seed[0], {{ 1 + fields | length }} + i);
    }
{% endif %}    for (int i = 0; i < {{ guard }}_PARAMETERS; ++i) {
        d.parameters[i] = number(seed[3], i);
    }
    {{ name }}_force_d(&axis, &d, 1, number(arg[1], 0), &d_x, number(arg[2], 0), &d_dt, {% for signal in signals %}number(arg[{{ 3 + loop.index }}], 0), &d_{{ signal }}, {% endfor %}d_force);
    d_next[0] = d.position;
{% for field in fields %}    d_next[{{ loop.index }}] = {{ "0.0" if field.capacity else "d.state." ~ field.name }};
{% endfor %}{% if memory %}    for (int i = 0; i < {{ memory }}; ++i) {
        d_next[{{ 1 + fields | length }} + i] = d.memory[i];
    }
{% endif %}    return (int)axis.flags;
}

EXPORTED int {{ name }}_step(const double **arg, double **res, casadi_int *iw, double *w, int mem)
{
    {{ name }} axis;
    (void)iw, (void)w, (void)mem;
    if (!unpacked(&axis, arg[0], arg[3])) {
        return 1;
    }
    const double force = {{ name }}_force{{ "_at" if signals }}(&axis, number(arg[1], 0), number(arg[2], 0){% for signal in signals %}, number(arg[{{ 3 + loop.index }}], 0){% endfor %});
    if (res[0]) {
        packed(&axis, res[0]);
    }
    if (res[1]) {
        res[1][0] = force;
    }
    return (int)axis.flags;
}

EXPORTED casadi_int {{ name }}_step_n_in(void) { return INPUTS; }
EXPORTED casadi_int {{ name }}_step_n_out(void) { return OUTPUTS; }
EXPORTED const casadi_int *{{ name }}_step_sparsity_in(casadi_int i) { return sizes_in[i]; }
EXPORTED const casadi_int *{{ name }}_step_sparsity_out(casadi_int i) { return sizes_out[i]; }

/* Forward: the inputs, the outputs and a change of each input; the change of each output. */
EXPORTED int fwd1_{{ name }}_step(const double **arg, double **res, casadi_int *iw, double *w, int mem)
{
    double d_next[STATES], d_force;
    (void)iw, (void)w, (void)mem;
    const int flags = changed(arg, arg + INPUTS + OUTPUTS, res[0] ? res[0] : d_next, res[1] ? res[1] : &d_force);
    return flags;
}

EXPORTED casadi_int fwd1_{{ name }}_step_n_in(void) { return 2 * INPUTS + OUTPUTS; }
EXPORTED casadi_int fwd1_{{ name }}_step_n_out(void) { return OUTPUTS; }
EXPORTED const casadi_int *fwd1_{{ name }}_step_sparsity_in(casadi_int i)
{
    return i < INPUTS ? sizes_in[i] : i < INPUTS + OUTPUTS ? sizes_out[i - INPUTS] : sizes_in[i - INPUTS - OUTPUTS];
}
EXPORTED const casadi_int *fwd1_{{ name }}_step_sparsity_out(casadi_int i) { return sizes_out[i]; }

/* Reverse: the inputs, the outputs and a weight of each output; the sensitivity of the weighted sum to each input. */
EXPORTED int adj1_{{ name }}_step(const double **arg, double **res, casadi_int *iw, double *w, int mem)
{
    const double *const *weight = arg + INPUTS + OUTPUTS;
    double unit[LARGEST] = {0.0}, d_next[STATES], d_force;
    (void)iw, (void)w, (void)mem;
    for (int input = 0; input < INPUTS; ++input) {
        for (int j = 0; res[input] && j < (int)sizes_in[input][0]; ++j) {
            const double *seed[INPUTS] = {0};
            seed[input] = unit;
            unit[j] = 1.0;
            if (changed(arg, seed, d_next, &d_force)) {
                return 1;
            }
            unit[j] = 0.0;
            double sum = number(weight[1], 0) * d_force;
            for (int i = 0; i < STATES; ++i) {
                sum += number(weight[0], i) * d_next[i];
            }
            res[input][j] = sum;
        }
    }
    return 0;
}

EXPORTED casadi_int adj1_{{ name }}_step_n_in(void) { return INPUTS + 2 * OUTPUTS; }
EXPORTED casadi_int adj1_{{ name }}_step_n_out(void) { return INPUTS; }
EXPORTED const casadi_int *adj1_{{ name }}_step_sparsity_in(casadi_int i) { return i < INPUTS ? sizes_in[i] : sizes_out[(i - INPUTS) % OUTPUTS]; }
EXPORTED const casadi_int *adj1_{{ name }}_step_sparsity_out(casadi_int i) { return sizes_in[i]; }

EXPORTED int {{ name }}_initial(const double **arg, double **res, casadi_int *iw, double *w, int mem)
{
    {{ name }} axis;
    (void)arg, (void)iw, (void)w, (void)mem;
    {{ name }}_start(&axis);
    if (res[0]) {
        packed(&axis, res[0]);
    }
    if (res[1]) {
{% for place in numbers %}        res[1][{{ loop.index0 }}] = axis.{{ place }};
{% endfor %}    }
    return 0;
}

EXPORTED casadi_int {{ name }}_initial_n_in(void) { return 0; }
EXPORTED casadi_int {{ name }}_initial_n_out(void) { return 2; }
EXPORTED const casadi_int *{{ name }}_initial_sparsity_in(casadi_int i) { return (void)i, (const casadi_int *)0; }
EXPORTED const casadi_int *{{ name }}_initial_sparsity_out(casadi_int i) { return i ? sizes_in[3] : sizes_in[0]; }
