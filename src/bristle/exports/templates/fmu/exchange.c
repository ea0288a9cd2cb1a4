/* --- model exchange ---------------------------------------------------------------------------------------------- */

/* Where the states and their rates are among the variables, and the sizes that matter to the contact. */
static const unsigned states_at[VARYING] = { {{- exchange.states | join(', ') -}} };
static const unsigned rates_at[VARYING] = { {{- exchange.rates | join(', ') -}} };
static const double nominals[VARYING] = { {{- exchange.nominals | join(', ') -}} };
/* How many values a whole number can take that holds; 0 where it is real. */
static const double most_held[HELD] = { {{- exchange.most | join(', ') -}} };

/* Return the force; write the rates of what varies, and behind them the margins to the next event. */
static double flowing(const Situation *now, double *slope)
{
{% for line in exchange.flowing[:-1] %}    {{ line }}
{% endfor %}    return {{ exchange.flowing[-1] }}
}

/* Begin a piece of smooth motion: write what varies, and what holds until the next event. */
static void begun(Situation *now)
{
{% for line in exchange.begun %}    {{ line }}
{% endfor %}}

/* At an event the memory is committed, and the next piece begins; the states stay as they are. */
static void turned(Situation *now)
{
    double states[VARYING];
    memcpy(states, now->varying, sizeof states);
{% for line in exchange.arrived %}    {{ line }}
{% endfor %}    begun(now);
    memcpy(now->varying, states, sizeof states);
}

/* Bring up to date what nobody integrates: all of it in co-simulation, and before the start. */
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

/* Bring up to date what is computed when somebody looks at it. */
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

/* Give the states values; say why not where they cannot have them. */
static const char *moved(Situation *now, const double *states, size_t count)
{
    if (now->phase != FLOWING || count != VARYING) {
        return "the states cannot be set now, or are not as many";
    }
    for (size_t i = 0; i < VARYING; ++i) {
        if (!is_finite(states[i])) {
            return "a state is no number";
        }
    }
    memcpy(now->varying, states, sizeof now->varying);
    return NULL;
}

