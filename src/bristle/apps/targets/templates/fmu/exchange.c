/* --- model exchange ---------------------------------------------------------------------------------------------- */

/* Value references of the states and of their rates, and the nominal values. */
static const unsigned states_at[VARYING] = { {{- exchange.states | join(', ') -}} };
static const unsigned rates_at[VARYING] = { {{- exchange.rates | join(', ') -}} };
static const double nominals[VARYING] = { {{- exchange.nominals | join(', ') -}} };
/* Number of values of each whole number that is constant between events; 0 for a real number. */
static const double most_held[HELD] = { {{- exchange.most | join(', ') -}} };

/* Return the force; write the rates of the states, followed by the margins to the next event. */
static double flowing(const Situation *now, double *slope)
{
{% for line in exchange.flowing[:-1] %}    {{ line }}
{% endfor %}    return {{ exchange.flowing[-1] }}
}

/* Begin a piece of smooth motion: write the states and the constants until the next event. */
static void begun(Situation *now)
{
{% for line in exchange.begun %}    {{ line }}
{% endfor %}}

/* Event: commit the memory and begin the next piece; the states do not change. */
static void turned(Situation *now)
{
    double states[VARYING];
    memcpy(states, now->varying, sizeof states);
{% for line in exchange.arrived %}    {{ line }}
{% endfor %}    begun(now);
    memcpy(now->varying, states, sizeof states);
}

/* Update the states that no importer integrates: all in co-simulation and before the start. */
static void ready(Situation *now)
{
    if (now->exchanged == 0U || now->phase <= STARTING) {
        begun(now);
    }
}

/* Write rates and margins; return whether the rates are numbers. */
static bool has_rates(Situation *now, double *slope)
{
    ready(now);
    double sum = flowing(now, slope);
    for (size_t i = 0; i < VARYING; ++i) {
        sum += slope[i];
    }
    return is_finite(sum);
}

/* Update the variables that are computed on demand. */
static void look(Situation *now)
{
    double slope[VARYING + 2U];
    ready(now);
    const double force = flowing(now, slope);
    for (size_t i = 0; i < VARYING; ++i) {
        now->values[states_at[i]] = now->varying[i];
        now->values[rates_at[i]] = slope[i];
    }
{% for place in exchange.margins %}    now->values[{{ place }}] = slope[VARYING + {{ loop.index0 }}U];
{% endfor %}    if (now->exchanged) {
        now->values[{{ output_at }}] = force;
    }
}

/* Set the states; return the reason if this is not allowed. */
static const char *moved(Situation *now, const double *states, size_t count)
{
    if (now->phase != FLOWING || count != VARYING) {
        return "the states cannot be set now, or their number is wrong";
    }
    for (size_t i = 0; i < VARYING; ++i) {
        if (!is_finite(states[i])) {
            return "a state is not a number";
        }
    }
    memcpy(now->varying, states, sizeof now->varying);
    return NULL;
}

/* Write the change of all variables that depend on the states and the inputs, in the direction of a change of these. */
static void changing(Situation *now, const double *seed, double *change)
{
    double slope[VARYING + 2U], d_varying[VARYING], d_slope[VARYING + 2U] = {0.0};
    ready(now);
    for (size_t i = 0; i < VARYING; ++i) {
        d_varying[i] = seed[states_at[i]];
    }
{% for line in exchange.changing[:-1] %}    {{ line }}
{% endfor %}    const {{ exchange.result }} = {{ exchange.changing[-1] }}
    for (size_t i = 0; i < VARYING; ++i) {
        change[states_at[i]] = d_varying[i];
        change[rates_at[i]] = d_slope[i];
    }
{% for place in exchange.margins %}    change[{{ place }}] = d_slope[VARYING + {{ loop.index0 }}U];
{% endfor %}    change[{{ output_at }}] = result.part_1;
}

/* Return whether derivatives exist of all unknowns by all knowns. */
static bool have_derivatives(const Situation *now, const unsigned *unknowns, size_t unknown_count,
                             const unsigned *knowns, size_t known_count)
{
    bool good = now->exchanged != 0U && now->phase != CREATED;
    for (size_t i = 0; good && i < unknown_count; ++i) {
        const unsigned role = unknowns[i] < VARIABLES ? roles[unknowns[i]] : A_TIME;
        good = role == AN_OUTPUT || role == A_START || role == A_STATE || role == A_RATE || role == A_MARGIN;
    }
    for (size_t i = 0; good && i < known_count; ++i) {
        const unsigned role = knowns[i] < VARIABLES ? roles[knowns[i]] : A_TIME;
        good = role == AN_INPUT || role == A_START || role == A_STATE;
    }
    return good;
}

