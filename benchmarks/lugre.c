/* The LuGre step at constant velocity, the same scheme as bristle.friction.lugre, written by hand in C. */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct {
    double F_C, F_S, v_S, sigma_0, sigma_1, sigma_2, v_d;
} lugre_parameters;

/* 2^k and e^r - 1 with x = k ln 2 + r: the polynomial of bristle.core.mathematics. */
static double scale_and_fraction(double x, double *fraction) {
    const double rounder = 6755399441055744.0;
    double k = (x * 1.4426950408889634 + rounder) - rounder;
    double r = (x - k * 6.93147180369123816490e-01) - k * 1.90821492927058770002e-10;
    double r2 = r * r, r4 = r2 * r2;
    double low = (0.5000000000000001 + 0.16666666666666669 * r) + (0.041666666666624164 + 0.008333333333330065 * r) * r2;
    double middle =
        (0.001388888891719689 + 0.00019841269863040675 * r) + (2.480152132210459e-05 + 2.7557268480106926e-06 * r) * r2;
    double high = 2.762007600563138e-07 + 2.5100375929185925e-08 * r;
    *fraction = (r + r2 * low) + (r2 * r4) * (middle + r4 * high);
    double bits = k + (rounder + 1023.0), scale;
    uint64_t moved;
    memcpy(&moved, &bits, sizeof moved);
    moved <<= 52;
    memcpy(&scale, &moved, sizeof scale);
    return scale;
}

static double clamped_exp(double x) {
    double fraction, scale = scale_and_fraction(x, &fraction);
    return x < -708.0 ? 0.0 : x > 709.0 ? 8.218407461554972e307 : scale * fraction + scale;
}

static double relaxation(double rate) {
    double positive = rate > 1e-30 ? rate : 1e-30;
    double fraction, scale = scale_and_fraction(-positive, &fraction);
    double expm1 = -positive < -708.0 ? -1.0 : scale * fraction + (scale - 1.0);
    return -expm1 / positive;
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
