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
        double sliding = copysign(1.0, v[k]) * G;
        double inverse = 1.0 / sliding;
        double elastic = p->sigma_0 * state;
        double decay = relaxation(p->sigma_0 * dx * inverse);
        double share = (1.0 - elastic * inverse) * decay;
        double damping = p->sigma_1;
        if (!isinf(p->v_d)) {
            double fade = v[k] / p->v_d;
            damping *= clamped_exp(-fade * fade);
        }
        force[k] = elastic + (sliding - elastic) * (1.0 - decay) + damping * (v[k] * share) + p->sigma_2 * v[k];
        state += dx * share;
    }
    *z = state;
}
