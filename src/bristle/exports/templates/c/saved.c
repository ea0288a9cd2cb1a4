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
{% for head in heads %}    at = put_real(at, axis->{{ head.name }});
{% endfor %}    at = put(at, (uint64_t)(uint32_t)axis->begun | ((uint64_t)(uint32_t)axis->flags << 32U));
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
    const uint64_t marks = got(bytes + {{ marks_at }});
    if ((marks & UINT64_C(0xFFFFFFFCFFFFFFFE)) != 0U{% for head in heads %} || !is_finite(got_real(bytes + {{ head.at }})){% endfor %}) {
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
{% endif %}{% for head in heads %}    axis->{{ head.name }} = got_real(bytes + {{ head.at }});
{% endfor %}    axis->begun = (int32_t)(marks & 1U);
    axis->flags = (int32_t)((marks >> 32U) & 3U);
{% for field in saved_state %}    {{ field.got }};
{% endfor %}{% if memory %}    for (size_t i = 0; i < {{ memory }}U; ++i) {
        axis->memory[i] = {{ narrowed }}got_real(bytes + {{ memory_at }} + 8U * i);
    }
{% endif %}{% if feed is defined and feed %}    axis->share = 0.0; /* the axis may have rested for long */
    axis->feed = 0.0;
{% endif %}    return 1;
}
