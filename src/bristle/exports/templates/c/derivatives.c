
void {{ name }}_start_d({{ name }}_tangent *d)
{
    d->position = 0.0;
    d->force = 0.0;
{% for field in d_state %}    d->state.{{ field }} = 0.0;
{% endfor %}{% if memory %}    for (int32_t i = 0; i < {{ memory }}; ++i) {
        d->memory[i] = 0.0;
    }
{% endif %}    for (int32_t i = 0; i < {{ guard }}_PARAMETERS; ++i) {
        d->parameters[i] = 0.0;
    }
}

double {{ name }}_force_d({{ name }} *axis, {{ name }}_tangent *d, size_t count, double x, const double *d_x, double dt, const double *d_dt,
{{ '    ' }}{% for signal in signals %}double {{ signal }}, const double *d_{{ signal }}, {% endfor %}double *d_force)
{
    const double velocity = {{ velocity }};
    const bool accepted = axis->begun && velocity - velocity == 0.0 && dt > 0.0 && dt <= DBL_MAX{% for signal in signals %} && is_finite({{ signal }}){% endfor %}{{ " && within_ranges(&axis->parameters)" if parameters }};
    for (size_t k = 0; k < count; ++k) {
        {{ name }}_tangent *const at = &d[k];
        const double d_x_k = d_x ? d_x[k] : 0.0;
        if (!axis->begun && is_finite(x)) {
            at->position = d_x_k;
        }
        if (accepted) {
            const double d_dt_k = d_dt ? d_dt[k] : 0.0;
            const double d_velocity = {{ d_velocity }};
{% for signal in signals %}            const double d_{{ signal }}_k = d_{{ signal }} ? d_{{ signal }}[k] : 0.0;
{% endfor %}{% if copies %}            double memory[{{ memory }}];
            for (int32_t i = 0; i < {{ memory }}; ++i) {
                memory[i] = axis->memory[i];
            }
{% endif %}{% for line in step_d %}    {{ line }}
{% endfor %}            if (is_finite(step.part_0.part_0)) {
                at->position = d_x_k;
                at->force = {{ d_force }};
{% for line in d_after %}                {{ line }}
{% endfor %}            }
        }
        d_force[k] = at->force;
    }
    return advanced(axis, x, dt{% for signal in signals %}, {{ signal }}{% endfor %});
}
