{% set also = " || !within_ranges(&axis->parameters)" if parameters else "" %}{{ device }}void {{ name }}_start({{ name }} *axis)
{
    axis->position = 0.0;
    axis->force = 0.0;
    axis->begun = 0;
    axis->flags = 0;
{% if feed %}    axis->gain = {{ guard }}_GAIN;
    axis->share = 0.0;
    axis->feed = 0.0;
{% endif %}{% for line in start %}    {{ line }}
{% endfor %}{% if memory %}    for (int32_t i = 0; i < {{ memory }}; ++i) {
        axis->memory[i] = {{ zero }};
    }
{% endif %}}

{% if operator %}{{ device }}double {{ name }}_output({{ name }} *axis, double x)
{
    if (!is_finite(x){{ also }}) {
        axis->flags |= {{ guard }}_REFUSED;
        return axis->force;
    }
    axis->begun = 1;
{% for line in step %}    {{ line }}
{% endfor %}    axis->position = x;
    return axis->force;
}
{% else %}{{ inline }} double advanced({{ name }} *axis, double x, double dt{% for signal in signals %}, double {{ signal }}{% endfor %})
{
    if (!axis->begun && is_finite(x)) {
        axis->position = x;
        axis->begun = 1;
        return axis->force;
    }
    const {{ scalar }} velocity = {{ velocity }};
    if (!(velocity - velocity == {{ zero }}) || !(dt > 0.0) || dt > DBL_MAX{% for signal in signals %} || !is_finite({{ signal }}){% endfor %}{{ also }}) {
        axis->flags |= {{ guard }}_REFUSED;
        return axis->force;
    }
{% for line in step %}    {{ line }}
{% endfor %}    axis->position = x;
    return axis->force;
}

{{ device }}double {{ name }}_force({{ name }} *axis, double x, double dt)
{
    return advanced(axis, x, dt{% if signals %}, {{ nominal }}{% endif %});
}
{% if signals %}
{{ device }}double {{ name }}_force_at({{ name }} *axis, double x, double dt{% for signal in signals %}, double {{ signal }}{% endfor %})
{
    return advanced(axis, x, dt{% for signal in signals %}, {{ signal }}{% endfor %});
}
{% endif %}{% if feed %}{% include "c/feed.c" %}{% endif %}{% endif %}