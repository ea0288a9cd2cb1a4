{% include "c/head.c" %}{% include "c/steps.c" %}{% if derived %}{% include "c/derivatives.c" %}{% endif %}
{% if drive %}double {{ name }}_command({{ name }} *axis, double position, double dt)
{
    return {{ name }}_{% if feed %}feed{% else %}force{% endif %}(axis, position * {{ guard }}_POSITION_UNIT, dt) / {{ guard }}_{{ drive.efforts[0].macro }};
}

{% endif %}{% include "c/saved.c" %}