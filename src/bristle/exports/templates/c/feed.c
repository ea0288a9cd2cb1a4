
{{ device }}double {{ name }}_feed({{ name }} *axis, double x, double dt)
{
    const double before = axis->position;
    const int32_t begun = axis->begun, flags = axis->flags;
    axis->flags = 0;
    const double force = {{ name }}_force(axis, x, dt);
    const int32_t refused = axis->flags;
    axis->flags |= flags;
    if (begun && !refused) {
        const {{ feed.rule }} rule = { {{- feed.cast }}axis->gain, {{ guard }}_RETURN_DISTANCE, {{ guard }}_FADE_TIME, {{ guard }}_CONSTANT, {{ guard }}_VISCOUS};
        const {{ scalar }} velocity = {{ feed.cast }}((x - before) / dt);
        const {{ feed.result }} now = {{ feed.portion }}({{ feed.cast }}force, {{ feed.cast }}axis->share, velocity, {{ feed.cast }}dt, rule);
        axis->share = now.{{ feed.share }};
        axis->feed = now.{{ feed.effort }};
    }
    return axis->feed;
}
