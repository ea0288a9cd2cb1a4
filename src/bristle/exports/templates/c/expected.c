{% if tolerance %}    /* What bristle gives in double precision; {{ tolerance }} of the largest may be missed in single precision. */
    static const double expected[] = { {{- checkpoints | join(', ') -}} };
    double worst = 0.0;
{% else %}    const double expected_last = {{ last }};
{% endif %}