{% if tolerance %}    /* Results of bristle in double precision; single precision may deviate by {{ tolerance }} of the largest. */
    static const double expected[] = { {{- checkpoints | join(', ') -}} };
    double worst = 0.0;
{% else %}    const double expected_last = {{ last }};
{% endif %}