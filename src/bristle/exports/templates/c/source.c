{% include "c/head.c" %}void {{ name }}_start({{ name }} *axis)
{
    axis->position = 0.0;
    axis->force = 0.0;
    axis->begun = 0;
    axis->flags = 0;
{% for line in start %}    {{ line }}
{% endfor %}{% if memory %}    for (int32_t i = 0; i < {{ memory }}; ++i) {
        axis->memory[i] = {{ zero }};
    }
{% endif %}}

{% if operator %}double {{ name }}_output({{ name }} *axis, double x)
{
    if (!is_finite(x)) {
        axis->flags |= {{ guard }}_REFUSED;
        return axis->force;
    }
    axis->begun = 1;
{% for line in step %}    {{ line }}
{% endfor %}    axis->position = x;
    return axis->force;
}
{% else %}static inline double advanced({{ name }} *axis, double x, double dt{% for signal in signals %}, double {{ signal }}{% endfor %})
{
    if (!axis->begun && is_finite(x)) {
        axis->position = x;
        axis->begun = 1;
        return axis->force;
    }
    const {{ scalar }} velocity = {{ velocity }};
    if (!(velocity - velocity == {{ zero }}) || !(dt > 0.0) || dt > DBL_MAX{% for signal in signals %} || !is_finite({{ signal }}){% endfor %}) {
        axis->flags |= {{ guard }}_REFUSED;
        return axis->force;
    }
{% for line in step %}    {{ line }}
{% endfor %}    axis->position = x;
    return axis->force;
}

double {{ name }}_force({{ name }} *axis, double x, double dt)
{
    return advanced(axis, x, dt{% if signals %}, {{ nominal }}{% endif %});
}
{% if signals %}
double {{ name }}_force_at({{ name }} *axis, double x, double dt{% for signal in signals %}, double {{ signal }}{% endfor %})
{
    return advanced(axis, x, dt{% for signal in signals %}, {{ signal }}{% endfor %});
}
{% endif %}{% endif %}
{% include "shared/bytes.c" %}static unsigned char *put_real(unsigned char *at, double value)
{
    const union { double number; uint64_t bits; } both = {value};
    return put(at, both.bits);
}

static double got_real(const unsigned char *at)
{
    union { double number; uint64_t bits; } both;
    both.bits = got(at);
    return both.number;
}

void {{ name }}_save(const {{ name }} *axis, unsigned char *bytes)
{
    unsigned char *at = put(bytes, UINT64_C({{ layout }}));
    at = put_real(at, axis->position);
    at = put_real(at, axis->force);
    at = put(at, (uint64_t)(uint32_t)axis->begun | ((uint64_t)(uint32_t)axis->flags << 32U));
{% for field in saved_state %}    at = {{ field.put }};
{% endfor %}{% if memory %}    for (int32_t i = 0; i < {{ memory }}; ++i) {
        at = put_real(at, {{ widened }}axis->memory[i]);
    }
{% endif %}    (void)put(at, digest(bytes, (size_t)(at - bytes)));
}

int {{ name }}_load({{ name }} *axis, const unsigned char *bytes, size_t size)
{
    const size_t last = {{ guard }}_SAVED - 8U;
    if (size != {{ guard }}_SAVED || got(bytes) != UINT64_C({{ layout }}) || got(bytes + last) != digest(bytes, last)) {
        return 0;
    }
    const uint64_t marks = got(bytes + 24);
    if ((marks & UINT64_C(0xFFFFFFFCFFFFFFFE)) != 0U || !is_finite(got_real(bytes + 8)) || !is_finite(got_real(bytes + 16))) {
        return 0;
    }
{% for field in saved_state %}{% if field.refused %}    if ({{ field.refused }}) {
        return 0;
    }
{% endif %}{% endfor %}{% if memory %}    for (size_t i = 0; i < {{ memory }}U; ++i) {
        if (!is_finite(got_real(bytes + {{ memory_at }} + 8U * i))) {
            return 0;
        }
    }
{% endif %}    axis->position = got_real(bytes + 8);
    axis->force = got_real(bytes + 16);
    axis->begun = (int32_t)(marks & 1U);
    axis->flags = (int32_t)((marks >> 32U) & 3U);
{% for field in saved_state %}    {{ field.got }};
{% endfor %}{% if memory %}    for (size_t i = 0; i < {{ memory }}U; ++i) {
        axis->memory[i] = {{ narrowed }}got_real(bytes + {{ memory_at }} + 8U * i);
    }
{% endif %}    return 1;
}
