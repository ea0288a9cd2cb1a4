/* {{ title }}.
   An FMU for FMI {{ fmi }}.0. Written by bristle {{ version }}; do not edit, export again.
{% for line in facts %}   {{ line | folded('   ') }}
{% endfor %}   Build with {{ flags }}: fused multiply-add changes the last bits of the results. */

#include "fmi{{ fmi }}Functions.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

{% include "shared/guards.c" %}/* --- the model ------------------------------------------------------------------------------------------------- */

{{ helpers }}
{{ definitions }}
{{ data }}
/* --- variables --------------------------------------------------------------------------------------------------- */

#define STEP {{ step }} /* [s] */
#define VARIABLES {{ ports | length }}U
#define LASTING {{ begin | length }}U
#define MEMORY {{ [memory, 1] | max }}U
#define TOKEN "{{ token }}"
{% if exchange %}#define VARYING {{ exchange.states | length }}U
#define HELD {{ [exchange.held | length, 1] | max }}U
#define MARGINS {{ exchange.margins | length }}U
#define SAVED (8U * (6U + VARIABLES + LASTING + MEMORY + VARYING + HELD))
{% else %}#define SAVED (8U * (5U + VARIABLES + LASTING + MEMORY))
{% endif %}#define LAYOUT UINT64_C({{ layout }})

enum { A_TIME, AN_INPUT, AN_OUTPUT, A_START, A_PARAMETER, A_CONSTANT, A_STATE, A_RATE, A_MARGIN };
enum { CREATED, STARTING, STEPPING, OVER, AT_EVENT, FLOWING };

static const unsigned char roles[VARIABLES] = { {{- roles | join(', ') -}} };
static const double starts[VARIABLES] = {
{% for port in ports %}    {{ port.start }}, /* {{ port.told }} */
{% endfor %}};
static const double lowest[VARIABLES] = { {{- lowest | join(', ') -}} };
static const double highest[VARIABLES] = { {{- highest | join(', ') -}} };
static const double virgin[LASTING] = { {{- begin | join(', ') -}} };
/* Number of values of each whole number of the state; 0 for a real number. */
static const double most[LASTING] = { {{- most | join(', ') -}} };

/* The whole state of an instance. */
typedef struct {
    uint64_t steps; /* internal steps done */
    double begin;   /* time of the first step [s] */
    uint64_t phase;
    double values[VARIABLES];
    double lasting[LASTING];
    double memory[MEMORY];
{% if exchange %}    uint64_t exchanged;      /* whether an importer integrates it */
    double varying[VARYING]; /* continuous states */
    double held[HELD];       /* constants until the next event */
{% endif %}} Situation;

static inline bool is_finite(double x)
{
    return x - x == 0.0;
}

static void begin_anew(Situation *now)
{
    now->steps = 0;
    now->begin = 0.0;
    now->phase = CREATED;
    memcpy(now->values, starts, sizeof starts);
    memcpy(now->lasting, virgin, sizeof virgin);
    for (size_t i = 0; i < MEMORY; ++i) {
        now->memory[i] = {{ remembered }};
    }
{% if exchange %}    for (size_t i = 0; i < VARYING; ++i) {
        now->varying[i] = 0.0;
    }
    for (size_t i = 0; i < HELD; ++i) {
        now->held[i] = 0.0;
    }
{% endif %}}

/* Set a variable; return the reason if this is not allowed. */
static const char *given(Situation *now, unsigned reference, double value)
{
    if (reference >= VARIABLES) {
        return "there is no variable with this value reference";
    }
    if (!(lowest[reference] <= value && value <= highest[reference])) {
        return "a value is outside its range";
    }
    if (roles[reference] == A_START && now->phase <= STARTING) {
        now->lasting[reference - {{ first_start }}U] = value;
    } else if (now->phase == OVER || (roles[reference] != AN_INPUT && roles[reference] != A_PARAMETER)) {
        return "the variable cannot be set at all, or not in this phase of the FMU";
    }
    now->values[reference] = value;
    return NULL;
}

static const char *one_step(Situation *now)
{
{% for line in stepping[:-1] %}    {{ line }}
{% endfor %}    const double {{ output }} = {{ stepping[-1] }}
    if (!is_finite({{ output }}){% if plant %} || !(magnitude_of(now->lasting[0]) + magnitude_of(now->lasting[1]) < 1e100){% endif %}) {
        return "the result is not a finite number";
    }
    now->values[{{ output_at }}] = {{ output }};
{% for reference, place in shown %}    now->values[{{ reference }}] = now->lasting[{{ place }}];
{% endfor %}    return NULL;
}

/* Advance to a time [s] in internal steps; the remainder of a step waits for the next call. If a step fails, the state
   does not change. */
static const char *gone_on(Situation *now, Situation *before, double time)
{
    const double far = (time - now->begin) / STEP + 1e-6;
    if (now->phase != STEPPING) {
        return "the step lies before the start or after the end";
    }
    if (!(far >= 0.0 && far < 9e15) || (uint64_t)far < now->steps) {
        return "the time goes backward, or is not a number";
    }
    *before = *now;
    for (const uint64_t last = (uint64_t)far; now->steps < last; ++now->steps) {
        const char *problem = one_step(now);
        if (problem) {
            *now = *before;
            return problem;
        }
    }
    now->values[0] = time;
    return NULL;
}

{% if exchange %}{% include "fmu/exchange.c" %}{% endif %}/* --- bytes ------------------------------------------------------------------------------------------------------- */

{% include "shared/bytes.c" %}static unsigned char *put_reals(unsigned char *at, const double *values, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        const union { double number; uint64_t bits; } both = {values[i]};
        at = put(at, both.bits);
    }
    return at;
}

static const unsigned char *got_reals(const unsigned char *at, double *values, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        union { double number; uint64_t bits; } both;
        both.bits = got(at);
        values[i] = both.number;
        at += 8;
    }
    return at;
}

static void save(const Situation *now, unsigned char *bytes)
{
    unsigned char *at = put(put(put(bytes, LAYOUT), now->steps), now->phase);
    at = put_reals(at, &now->begin, 1);
    at = put_reals(at, now->values, VARIABLES);
    at = put_reals(at, now->lasting, LASTING);
    at = put_reals(at, now->memory, MEMORY);
{% if exchange %}    at = put(at, now->exchanged);
    at = put_reals(at, now->varying, VARYING);
    at = put_reals(at, now->held, HELD);
{% endif %}    (void)put(at, digest(bytes, SAVED - 8U));
}

/* Read a saved state; false if the bytes are damaged, of another FMU, or contain an impossible state. */
static bool restored(Situation *then, const unsigned char *bytes, size_t size)
{
    if (size != SAVED || got(bytes) != LAYOUT || got(bytes + SAVED - 8U) != digest(bytes, SAVED - 8U)) {
        return false;
    }
    then->steps = got(bytes + 8);
    then->phase = got(bytes + 16);
    const unsigned char *at = got_reals(bytes + 24, &then->begin, 1);
    at = got_reals(at, then->values, VARIABLES);
    at = got_reals(at, then->lasting, LASTING);
    {% if exchange %}at = {% else %}(void){% endif %}got_reals(at, then->memory, MEMORY);
{% if exchange %}    then->exchanged = got(at);
    at = got_reals(at + 8, then->varying, VARYING);
    (void)got_reals(at, then->held, HELD);
{% endif %}    bool good = then->phase <= {% if exchange %}FLOWING{% else %}OVER{% endif %} && then->steps < UINT64_C(9000000000000000) && is_finite(then->begin);
    for (size_t i = 0; i < VARIABLES; ++i) {
        good = good && lowest[i] <= then->values[i] && then->values[i] <= highest[i];
    }
    for (size_t i = 0; i < LASTING; ++i) {
        const double value = then->lasting[i];
        good = good && is_finite(value);
        good = good && (most[i] == 0.0 || (value >= 0.0 && value < most[i] && value == (double)(uint64_t)value));
    }
    for (size_t i = 0; i < MEMORY; ++i) {
        good = good && is_finite(then->memory[i]);
    }
{% if exchange %}    good = good && then->exchanged <= 1U && (then->exchanged == 1U ? then->phase != STEPPING : then->phase <= OVER);
    for (size_t i = 0; i < VARYING; ++i) {
        good = good && is_finite(then->varying[i]);
    }
    for (size_t i = 0; i < HELD; ++i) {
        const double value = then->held[i]; /* may be infinite: the end of a branch */
        good = good && value == value;
        good = good && (most_held[i] == 0.0 || (value >= 0.0 && value < most_held[i] && value == (double)(uint64_t)value));
    }
{% endif %}    return good;
}

/* Return a copy of a restored state in `state`; false, without a change, if it is refused. */
static bool handed_out(void **state, const unsigned char *bytes, size_t size)
{
    Situation *then = malloc(sizeof *then);
    if (!then || !restored(then, bytes, size)) {
        free(then);
        return false;
    }
    free(*state);
    *state = then;
    return true;
}

/* --- FMI {{ fmi }}.0 ------------------------------------------------------------------------------------------------------ */

{% include "fmu/interface" ~ fmi ~ ".c" %}
/* --- unsupported functions --------------------------------------------------------------------------------------- */

{{ absent }}
