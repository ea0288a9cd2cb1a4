/* The LuGre step at constant velocity, the same scheme as bristle.friction.lugre, written by hand in C. */
#include <math.h>
#include <stddef.h>

typedef struct {
    double F_C, F_S, v_S, sigma_0, sigma_1, sigma_2, v_d;
} lugre_parameters;

static double clamped_exp(double x) {
    if (x > 709.0) return exp(709.0);
    if (x < -745.0) return 0.0;
    return exp(x);
}

static double relaxation(double rate) {
    if (rate < 1e-12) return 1.0 - 0.5 * rate;
    return -expm1(-rate) / rate;
}

void lugre_run(const lugre_parameters *p, double *z, const double *v, double dt, double *force, size_t count) {
    double state = *z;
    for (size_t k = 0; k < count; k++) {
        double ratio = v[k] / p->v_S;
        double G = p->F_C + (p->F_S - p->F_C) * clamped_exp(-ratio * ratio);
        double dx = v[k] * dt;
        double z_steady = copysign(1.0, v[k]) * G / p->sigma_0;
        double decay = relaxation(fabs(dx / z_steady));
        double z_step = dx * (1.0 - state / z_steady) * decay;
        double z_mean = state + (z_steady - state) * (1.0 - decay);
        double z_dot = dt > 0.0 ? z_step / dt : 0.0;
        double damping = p->sigma_1;
        if (!isinf(p->v_d)) {
            double fade = v[k] / p->v_d;
            damping *= clamped_exp(-fade * fade);
        }
        force[k] = p->sigma_0 * z_mean + damping * z_dot + p->sigma_2 * v[k];
        state += z_step;
    }
    *z = state;
}
