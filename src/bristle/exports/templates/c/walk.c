/* Walks with derivatives: forward with one tangent, and in reverse with a tape.

   Each function handles `lanes` axes with `steps` steps. `in` has the arrays state, x, dt, parameters{% for signal in signals %}, {{ signal }}{% endfor %}, lane after lane. A
   state is position, force, `begun`, the numbers of the state, and the memory. The result is 0; 1 if the machine lacks memory; or 2
   if a state is not of this model. */

#include "friction.h"
#include "tape.h"
#include "taped.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

Tape tape;
static pthread_mutex_t of_tape = PTHREAD_MUTEX_INITIALIZER;

int tape_enlarged(void)
{
    const uint32_t room = tape.room < 1024U ? 1024U : 2U * tape.room;
    TapeEntry *const entries = room < tape.room ? NULL : realloc(tape.entries, (size_t)room * sizeof *entries);
    if (entries == NULL) {
        tape.failed = 1;
        return 0;
    }
    tape.entries = entries;
    tape.room = room;
    return 1;
}

enum { NUMBERS = {{ 3 + fields | length + memory }}, PARAMETERS = FRICTION_PARAMETERS, SIGNALS = {{ signals | length }}, INPUTS = 4 + SIGNALS, FIRST_MEMORY = NUMBERS - {{ memory }} };

static const size_t PER_LANE[INPUTS] = {NUMBERS, 0, 1, PARAMETERS}; /* 0: one number in each step */

static size_t width(size_t input, size_t steps)
{
    return PER_LANE[input] ? PER_LANE[input] : steps;
}

{% for name in ("friction", "taped") %}static int {{ name }}_begun({{ name }} *axis, const double *state, const double *parameters)
{
    {{ name }}_start(axis);
    axis->position = state[0];
    axis->force = state[1];
    axis->begun = state[2] != 0.0;
{% for field in fields %}{% if field.capacity %}    if (!(state[{{ 3 + loop.index0 }}] >= 0.0 && state[{{ 3 + loop.index0 }}] < {{ field.capacity }}.0)) {
        return 0;
    }
{% endif %}    axis->state.{{ field.name }} = ({{ field.type }})state[{{ 3 + loop.index0 }}];
{% endfor %}{% if memory %}    memcpy(axis->memory, state + FIRST_MEMORY, sizeof axis->memory);
{% endif %}    memcpy(&axis->parameters, parameters, PARAMETERS * sizeof(double));
    return 1;
}

{% endfor %}static void ended(const friction *axis, double *state)
{
    state[0] = axis->position;
    state[1] = axis->force;
    state[2] = axis->begun;
{% for field in fields %}    state[{{ 3 + loop.index0 }}] = (double)axis->state.{{ field.name }};
{% endfor %}{% if memory %}    memcpy(state + FIRST_MEMORY, axis->memory, sizeof axis->memory);
{% endif %}}

/* `out` has the arrays state and force. */
int walk(size_t lanes, size_t steps, const double *const *in, double *const *out)
{
    friction axis;
    for (size_t lane = 0; lane < lanes; ++lane) {
        if (!friction_begun(&axis, in[0] + lane * NUMBERS, in[3] + lane * PARAMETERS)) {
            return 2;
        }
        for (size_t k = lane * steps; k < (lane + 1) * steps; ++k) {
            out[1][k] = friction_force{{ '_at' if signals }}(&axis, in[1][k], in[2][lane]{% for signal in signals %}, in[{{ 4 + loop.index0 }}][k]{% endfor %});
        }
        ended(&axis, out[0] + lane * NUMBERS);
    }
    return 0;
}

/* `in` also has the tangents of its arrays; `out` has those of state and force. */
int walk_forward(size_t lanes, size_t steps, const double *const *in, double *const *out)
{
    friction axis;
    friction_tangent d;
    const double *const *const d_in = in + INPUTS;
    for (size_t lane = 0; lane < lanes; ++lane) {
        const double *const d_state = d_in[0] + lane * NUMBERS;
        double *const d_end = out[0] + lane * NUMBERS;
        if (!friction_begun(&axis, in[0] + lane * NUMBERS, in[3] + lane * PARAMETERS)) {
            return 2;
        }
        friction_start_d(&d);
        d.position = d_state[0];
        d.force = d_state[1];
{% for field in fields %}{% if not field.capacity %}        d.state.{{ field.name }} = d_state[{{ 3 + loop.index0 }}];
{% endif %}{% endfor %}{% if memory %}        memcpy(d.memory, d_state + FIRST_MEMORY, sizeof d.memory);
{% endif %}        memcpy(d.parameters, d_in[3] + lane * PARAMETERS, sizeof d.parameters);
        for (size_t k = lane * steps; k < (lane + 1) * steps; ++k) {
            (void)friction_force_d(&axis, &d, 1, in[1][k], d_in[1] + k, in[2][lane], d_in[2] + lane{% for signal in signals %}, in[{{ 4 + loop.index0 }}][k], d_in[{{ 4 + loop.index0 }}] + k{% endfor %}, out[1] + k);
        }
        memset(d_end, 0, NUMBERS * sizeof(double));
        d_end[0] = d.position;
        d_end[1] = d.force;
{% for field in fields %}{% if not field.capacity %}        d_end[{{ 3 + loop.index0 }}] = d.state.{{ field.name }};
{% endif %}{% endfor %}{% if memory %}        memcpy(d_end + FIRST_MEMORY, d.memory, sizeof d.memory);
{% endif %}    }
    return 0;
}

/* Record steps on the tape and add the adjoints of their inputs; `bar` are those of the state at the end, then at the beginning.
   The first indices are the numbers of the state, the parameters, dt, and x and the signals of each step. */
static int swept(taped *axis, size_t count, const double *const *in, const double *force_bar, double *bar, double *const *out)
{
    enum { OF_STATE = 1, OF_PARAMETERS = OF_STATE + NUMBERS, OF_DT = OF_PARAMETERS + PARAMETERS, OF_STEPS };
    const size_t first = OF_STEPS + count * (1U + SIGNALS);
    taped_tangent d;
    taped_start_d(&d);
    d.position = tape_tangent(OF_STATE);
    d.force = tape_tangent(OF_STATE + 1);
{% for field in fields %}{% if not field.capacity %}    d.state.{{ field.name }} = tape_tangent(OF_STATE + {{ 3 + loop.index0 }});
{% endif %}{% endfor %}{% if memory %}    for (uint32_t i = 0; i < {{ memory }}U; ++i) {
        d.memory[i] = tape_tangent(OF_STATE + FIRST_MEMORY + i);
    }
{% endif %}    for (uint32_t i = 0; i < PARAMETERS; ++i) {
        d.parameters[i] = tape_tangent(OF_PARAMETERS + i);
    }
    while ((size_t)tape.room < first + count) {
        if (!tape_enlarged()) {
            return 0;
        }
    }
    tape.used = (uint32_t)first;
    double *const of_force = malloc(count * sizeof *of_force);
    if (of_force == NULL) {
        return 0;
    }
    for (size_t k = 0; k < count; ++k) {
        const uint32_t at = (uint32_t)(OF_STEPS + k * (1U + SIGNALS));
        const double of_dt = tape_tangent(OF_DT), of_x = tape_tangent(at){% for signal in signals %}, d_{{ signal }} = tape_tangent(at + {{ loop.index }}U){% endfor %};
        (void)taped_force_d(axis, &d, 1, in[1][k], &of_x, in[2][0], &of_dt{% for signal in signals %}, in[{{ 4 + loop.index0 }}][k], &d_{{ signal }}{% endfor %}, of_force + k);
    }
    double *const adjoint = tape.failed ? NULL : calloc(tape.used, sizeof *adjoint);
    if (adjoint == NULL) {
        free(of_force);
        return 0;
    }
    for (size_t k = 0; k < count; ++k) {
        adjoint[tape_index(of_force[k])] += force_bar[k];
    }
    adjoint[tape_index(d.position)] += bar[0];
    adjoint[tape_index(d.force)] += bar[1];
{% for field in fields %}{% if not field.capacity %}    adjoint[tape_index(d.state.{{ field.name }})] += bar[{{ 3 + loop.index0 }}];
{% endif %}{% endfor %}{% if memory %}    for (int i = 0; i < {{ memory }}; ++i) {
        adjoint[tape_index(d.memory[i])] += bar[FIRST_MEMORY + i];
    }
{% endif %}    for (size_t i = tape.used; i-- > first;) {
        const TapeEntry *const entry = &tape.entries[i];
        if (adjoint[i] != 0.0) {
            adjoint[entry->of[0]] += entry->slope[0] * adjoint[i];
            adjoint[entry->of[1]] += entry->slope[1] * adjoint[i];
        }
    }
    memcpy(bar, adjoint + OF_STATE, NUMBERS * sizeof(double));
    for (size_t i = 0; i < PARAMETERS; ++i) {
        out[3][i] += adjoint[OF_PARAMETERS + i];
    }
    out[2][0] += adjoint[OF_DT];
    for (size_t k = 0; k < count; ++k) {
        const double *const of_step = adjoint + OF_STEPS + k * (1U + SIGNALS);
        out[1][k] = of_step[0];
{% for signal in signals %}        out[{{ 4 + loop.index0 }}][k] = of_step[{{ loop.index }}];
{% endfor %}    }
    free(adjoint);
    free(of_force);
    return 1;
}

static int reversed(size_t steps, taped *axis, taped *saved, size_t length, const double *const *in, const double *force_bar, double *bar, double *const *out)
{
    for (size_t k = 0; k < steps; ++k) {
        if (k % length == 0) {
            saved[k / length] = *axis;
        }
        (void)taped_force{{ '_at' if signals }}(axis, in[1][k], in[2][0]{% for signal in signals %}, in[{{ 4 + loop.index0 }}][k]{% endfor %});
    }
    for (size_t segment = (steps + length - 1) / length; segment-- > 0;) {
        const size_t begin = segment * length, count = steps - begin < length ? steps - begin : length;
        const double *inputs[INPUTS];
        double *adjoints[INPUTS];
        for (size_t i = 0; i < INPUTS; ++i) {
            inputs[i] = in[i] + (PER_LANE[i] ? 0 : begin);
            adjoints[i] = out[i] + (PER_LANE[i] ? 0 : begin);
        }
        if (!swept(&saved[segment], count, inputs, force_bar + begin, bar, adjoints)) {
            return 0;
        }
    }
    return 1;
}

/* `in` also has the adjoints of state and force at the end; `out` has those of the arrays of `in`. A walk is recomputed from
   states at the beginning of segments, whose length is about the square root of the number of steps. */
int walk_reverse(size_t lanes, size_t steps, const double *const *in, double *const *out)
{
    size_t length = 1;
    int result = 0;
    while (length * length < steps) {
        ++length;
    }
    taped axis, *const saved = malloc(((steps + length - 1) / length + 1) * sizeof *saved);
    (void)pthread_mutex_lock(&of_tape);
    tape.failed = 0;
    for (size_t lane = 0; lane < lanes && result == 0; ++lane) {
        const double *inputs[INPUTS];
        double *adjoints[INPUTS];
        for (size_t i = 0; i < INPUTS; ++i) {
            inputs[i] = in[i] + lane * width(i, steps);
            adjoints[i] = out[i] + lane * width(i, steps);
            memset(adjoints[i], 0, width(i, steps) * sizeof(double));
        }
        memcpy(adjoints[0], in[INPUTS] + lane * NUMBERS, NUMBERS * sizeof(double));
        if (!taped_begun(&axis, inputs[0], inputs[3])) {
            result = 2;
        } else if (saved == NULL || !reversed(steps, &axis, saved, length, inputs, in[INPUTS + 1] + lane * steps, adjoints[0], adjoints)) {
            result = 1;
        }
    }
    free(tape.entries);
    tape.entries = NULL;
    tape.room = 0;
    (void)pthread_mutex_unlock(&of_tape);
    free(saved);
    return result;
}
