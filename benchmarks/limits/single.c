// One linear run, its history written: a chain of as many multiply-adds a step as are carried, bound by their latency.
#include <stddef.h>

// x1 = x0 + D x0 + B0 f_n + B1 f_n+1 for (u, hv), then h^2 a = f - damping*hv - stiffness*u; out (n + 1, 3)
void single(ptrdiff_t n, const double *D, const double *B0, const double *B1, double damping, double stiffness,
            const double *f, double *out) {
    double d00 = 1.0 + D[0], d01 = D[1], d10 = D[2], d11 = 1.0 + D[3], u = out[0], v = out[1];
    double b00 = B0[0], b10 = B0[1], b01 = B1[0], b11 = B1[1];
    for (ptrdiff_t i = 1; i <= n; i++) {
        double load_u = b00 * f[i - 1] + b01 * f[i], load_v = b10 * f[i - 1] + b11 * f[i];
        double new_u = d00 * u + (d01 * v + load_u), new_v = d11 * v + (d10 * u + load_v);
        u = new_u, v = new_v;
        out[3 * i] = u, out[3 * i + 1] = v, out[3 * i + 2] = f[i] - damping * v - stiffness * u;
    }
}

// As `single`, but D x0 is added to x0: a longer chain of operations, which keeps the digits of small steps
void single_increment(ptrdiff_t n, const double *D, const double *B0, const double *B1, double damping,
                      double stiffness, const double *f, double *out) {
    double u = out[0], v = out[1];
    for (ptrdiff_t i = 1; i <= n; i++) {
        double load_u = B0[0] * f[i - 1] + B1[0] * f[i], load_v = B0[1] * f[i - 1] + B1[1] * f[i];
        double change_u = D[0] * u + (D[1] * v + load_u), change_v = D[3] * v + (D[2] * u + load_v);
        u += change_u, v += change_v;
        out[3 * i] = u, out[3 * i + 1] = v, out[3 * i + 2] = f[i] - damping * v - stiffness * u;
    }
}

// x1 = x0 + D x0 + B0 f_n + B1 f_n+1 for (u, hv, h^2 a), all of them carried; out (n + 1, 3)
void single_three(ptrdiff_t n, const double *D, const double *B0, const double *B1, const double *f, double *out) {
    double d00 = 1.0 + D[0], d01 = D[1], d02 = D[2], d10 = D[3], d11 = 1.0 + D[4], d12 = D[5];
    double d20 = D[6], d21 = D[7], d22 = 1.0 + D[8], u = out[0], v = out[1], a = out[2];
    for (ptrdiff_t i = 1; i <= n; i++) {
        double load_u = B0[0] * f[i - 1] + B1[0] * f[i], load_v = B0[1] * f[i - 1] + B1[1] * f[i];
        double load_a = B0[2] * f[i - 1] + B1[2] * f[i];
        double new_u = d00 * u + (d01 * v + (d02 * a + load_u)), new_v = d11 * v + (d10 * u + (d12 * a + load_v));
        double new_a = d22 * a + (d20 * u + (d21 * v + load_a));
        u = new_u, v = new_v, a = new_a;
        out[3 * i] = u, out[3 * i + 1] = v, out[3 * i + 2] = a;
    }
}
