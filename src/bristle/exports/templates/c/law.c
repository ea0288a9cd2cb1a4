{% include "c/head.c" %}void {{ name }}_start({{ name }} *axis)
{
    axis->effort = 0.0;
    axis->begun = 0;
    axis->flags = 0;
{% for line in start %}    {{ line }}
{% endfor %}{% if memory %}    for (int32_t i = 0; i < {{ memory }}; ++i) {
        axis->memory[i] = {{ remembered }};
    }
{% endif %}}

double {{ name }}_effort({{ name }} *axis, const {{ name }}_inputs *inputs)
{
    bool finite = true;
{% for input in inputs %}{% if input.several %}    for (int32_t i = 0; i < {{ ahead }}; ++i) {
        finite = finite && is_finite(inputs->{{ input.name }}[i]);
    }
{% else %}    finite = finite && is_finite(inputs->{{ input.name }});
{% endif %}{% endfor %}    if (!finite{% if parameters %} || !within_ranges(&axis->parameters){% endif %}) {
        axis->flags |= {{ guard }}_REFUSED;
        return axis->effort;
    }
{% for line in step %}    {{ line }}
{% endfor %}    if (!is_finite(now.part_0)) {
        axis->flags |= {{ guard }}_OVERFLOW;
        return axis->effort;
    }
{% for line in after %}    {{ line }}
{% endfor %}    axis->effort = now.part_0;
    axis->begun = 1;
    return axis->effort;
}

{% if drive %}double {{ name }}_command({{ name }} *axis, const {{ name }}_inputs *inputs)
{
    return {{ name }}_effort(axis, inputs) / {{ guard }}_{{ drive.efforts[0].macro }};
}

{% endif %}{% include "c/saved.c" %}