/* The Preisach operator from its turning points, the same algorithm as bristle.hysteresis.preisach, by hand in C. */
#include <math.h>
#include <stddef.h>

typedef struct {
    double s, f_p;
    long kernel; /* 0: dahl_masing of exponent 2, 2: reformed_dahl_exact */
    double tolerance;
} preisach_parameters;

static double loop_tip(double k) {
    double near = k < 1e150 ? k : 1e150;
    return 2.0 * near / (sqrt(1.0 + near * (6.0 + near)) + 1.0 + near);
}

static double everett(const preisach_parameters *p, double alpha, double beta) {
    double x = p->s * (alpha - beta);
    if (p->kernel == 2) {
        double far = alpha > -beta ? alpha : -beta;
        double reach = p->f_p * (1.0 + loop_tip(p->s * far / p->f_p));
        return 0.5 * reach * (x / (reach + x));
    }
    double k = 0.5 * x / p->f_p;
    return p->f_p * (k / (1.0 + k));
}

static double virgin(const preisach_parameters *p, double u) {
    double k = p->s * fabs(u) / p->f_p;
    return copysign(p->f_p * (p->kernel == 2 ? loop_tip(k) : k / (1.0 + k)), u);
}

/* Returns how many pairs were forgotten for lack of room. */
long preisach_run(const preisach_parameters *p, double *z, double *f, long capacity, const double *u, double *w,
                  size_t count) {
    double at = 0.0, out = 0.0, side = 0.0, tolerance = p->tolerance * p->f_p / p->s;
    long depth = 0, lost = 0;
    for (size_t k = 0; k < count; k++) {
        double move = u[k] - at;
        if (fabs(move) <= tolerance && move * side < 0.0) {
            w[k] = out;
            continue;
        }
        double towards = move > 0.0 ? 1.0 : move < 0.0 ? -1.0 : side;
        if (towards * side < 0.0) {
            if (depth == capacity) {
                depth -= 2;
                lost++;
            }
            z[depth] = at;
            f[depth] = out;
            depth++;
        }
        while (depth >= 2 && towards * (u[k] - z[depth - 2]) >= 0.0) depth -= 2;
        if (depth == 1 && towards * (u[k] + z[0]) >= 0.0) depth = 0;
        if (depth == 0) {
            out = virgin(p, u[k]);
        } else {
            double from = z[depth - 1];
            double alpha = u[k] > from ? u[k] : from, beta = u[k] > from ? from : u[k];
            out = f[depth - 1] + 2.0 * towards * everett(p, alpha, beta);
        }
        at = u[k];
        side = towards;
        w[k] = out;
    }
    return lost;
}
