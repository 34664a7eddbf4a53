// Elastic pendulum (Green-Lagrange bar): newmark_bdf2 (bathe is gamma_t = 1/2, beta = 1/4, gamma = 1/2), and
// generalized_alpha (newmark is alpha_m = alpha_f = 0). Newton per sub-step for the acceleration, from the last converged
// position. Compiled twice: GROUPS vectors in flight, which iterate until all their lanes have converged, or (SCALAR)
// one lane at a time.
#ifdef SCALAR
#include <math.h>
#include <stddef.h>
#define LANES 1
#define GROUPS 1
#define INLINE static inline __attribute__((always_inline))
typedef double vec;
typedef int mask;
INLINE vec load(const double *p) { return *p; }
INLINE void store(double *p, vec x) { *p = x; }
INLINE vec all(double x) { return x; }
INLINE mask less(vec a, vec b) { return a < b; }
INLINE vec largest(vec a, vec b) { return a > b ? a : b; }
INLINE vec magnitude(vec a) { return fabs(a); }
INLINE int any(mask m) { return m; }
#else
#include "vectors.h"
#define GROUPS 4
#endif
#define MOST 50
#define JOINED_(name) name##_alpha
#define JOINED(name) JOINED_(name)

// a with mass a + k (|u|^2 - L^2) u + rest = 0 at u = start + c a, rest 0 for NULL; a in: the first guess. Returns
// whether all lanes converged.
INLINE int balance(vec a[2][GROUPS], vec start[2][GROUPS], vec c, vec k[GROUPS], vec L2, vec tolerance, double mass,
                   vec (*rest)[GROUPS]) {
    for (int count = 0; count < MOST; count++) {
        mask open = (mask)(less(all(0.0), all(0.0)));
        for (int g = 0; g < GROUPS; g++) {
            vec x = start[0][g] + c * a[0][g], y = start[1][g] + c * a[1][g];
            vec square = x * x + y * y, force = k[g] * (square - L2);
            vec rx = mass * a[0][g] + x * force, ry = mass * a[1][g] + y * force;
            if (rest) rx += rest[0][g], ry += rest[1][g];
            vec diagonal = mass + c * force, rank = 2.0 * c * k[g];  // Jacobian: diagonal I + rank u u'
            vec other = diagonal + rank * square, along = rank * (x * rx + y * ry);
            vec inverse = 1.0 / (diagonal * other);
            vec dx = (other * rx - x * along) * inverse, dy = (other * ry - y * along) * inverse;
            a[0][g] -= dx, a[1][g] -= dy;
            open |= less(tolerance, c * largest(magnitude(dx), magnitude(dy)));
        }
        if (!any(open)) return 1;
    }
    return 0;
}

INLINE vec energy_per_mass(vec x, vec y, vec vx, vec vy, vec k, vec L2) {
    vec stretch = x * x + y * y - L2;
    return 0.5 * (vx * vx + vy * vy) + 0.25 * k * stretch * stretch;
}

// x and y of u, v or a: two rows of the state
INLINE void read_vector(vec x[2][GROUPS], const double *state, ptrdiff_t lanes) {
    for (int r = 0; r < 2; r++)
        for (int k = 0; k < GROUPS; k++) x[r][k] = load(state + r * lanes + k * LANES);
}

INLINE void write_vector(vec x[2][GROUPS], double *state, ptrdiff_t lanes) {
    for (int r = 0; r < 2; r++)
        for (int k = 0; k < GROUPS; k++) store(state + r * lanes + k * LANES, x[r][k]);
}

// state (6, lanes): u, v, a, x and y of each, overwritten; peak (lanes): largest energy per mass, the start's included.
// stiffness (lanes): EA/(2 L^3 m). lanes a multiple of GROUPS*LANES. Returns the steps completed by all lanes.
ptrdiff_t MARCH(ptrdiff_t lanes, ptrdiff_t n, double h, double gamma_t, double beta, double gamma, double L,
                double tolerance, const double *stiffness, double *state, double *peak) {
    double g = gamma_t, step = g * h, c1 = beta * step * step, w = (1.0 - g) * h / (2.0 - g), c2 = w * w;
    double p = 1.0 / (g * (2.0 - g)), q = (1.0 - g) * (1.0 - g) * p;  // u_1 = p u_g - q u_0 + w v_1, and so for v
    double inverse1 = 1.0 / c1, inverse2 = 1.0 / c2;
    ptrdiff_t done = n;
    for (ptrdiff_t j = 0; j + GROUPS * LANES <= lanes; j += GROUPS * LANES) {
        vec u[2][GROUPS], v[2][GROUPS], a[2][GROUPS], top[GROUPS], stiff[GROUPS], L2 = all(L * L);
        read_vector(u, state + j, lanes), read_vector(v, state + 2 * lanes + j, lanes);
        read_vector(a, state + 4 * lanes + j, lanes);
        for (int k = 0; k < GROUPS; k++) {
            stiff[k] = load(stiffness + j + k * LANES);
            top[k] = energy_per_mass(u[0][k], u[1][k], v[0][k], v[1][k], stiff[k], L2);
        }
        for (ptrdiff_t i = 0; i < n; i++) {
            vec start[2][GROUPS], z[2][GROUPS], inner_u[2][GROUPS], inner_v[2][GROUPS];
            for (int r = 0; r < 2; r++)
                for (int k = 0; k < GROUPS; k++) {
                    start[r][k] = u[r][k] + step * v[r][k] + step * step * (0.5 - beta) * a[r][k];
                    z[r][k] = (u[r][k] - start[r][k]) * inverse1;
                }
            int good = balance(z, start, all(c1), stiff, L2, all(tolerance), 1.0, NULL);
            for (int r = 0; r < 2; r++)
                for (int k = 0; k < GROUPS; k++) {
                    inner_u[r][k] = start[r][k] + c1 * z[r][k];
                    inner_v[r][k] = v[r][k] + step * ((1.0 - gamma) * a[r][k] + gamma * z[r][k]);
                    v[r][k] = p * inner_v[r][k] - q * v[r][k];
                    start[r][k] = p * inner_u[r][k] - q * u[r][k] + w * v[r][k];
                    z[r][k] = (inner_u[r][k] - start[r][k]) * inverse2;
                }
            good &= balance(z, start, all(c2), stiff, L2, all(tolerance), 1.0, NULL);
            for (int k = 0; k < GROUPS; k++) {
                for (int r = 0; r < 2; r++) {
                    a[r][k] = z[r][k];
                    u[r][k] = start[r][k] + c2 * z[r][k];
                    v[r][k] += w * z[r][k];
                }
                top[k] = largest(top[k], energy_per_mass(u[0][k], u[1][k], v[0][k], v[1][k], stiff[k], L2));
            }
            if (!good) {
                if (i < done) done = i;
                break;
            }
        }
        write_vector(u, state + j, lanes), write_vector(v, state + 2 * lanes + j, lanes);
        write_vector(a, state + 4 * lanes + j, lanes);
        for (int k = 0; k < GROUPS; k++) store(peak + j + k * LANES, top[k]);
    }
    return done;
}

// The march by generalized_alpha, with the arguments that the one by newmark_bdf2 has
ptrdiff_t JOINED(MARCH)(ptrdiff_t lanes, ptrdiff_t n, double h, double alpha_m, double alpha_f, double beta,
                        double gamma, double L, double tolerance, const double *stiffness, double *state,
                        double *peak) {
    double c = beta * h * h, inverse = 1.0 / c;
    ptrdiff_t done = n;
    for (ptrdiff_t j = 0; j + GROUPS * LANES <= lanes; j += GROUPS * LANES) {
        vec u[2][GROUPS], v[2][GROUPS], a[2][GROUPS], top[GROUPS], stiff[GROUPS], later[GROUPS], L2 = all(L * L);
        read_vector(u, state + j, lanes), read_vector(v, state + 2 * lanes + j, lanes);
        read_vector(a, state + 4 * lanes + j, lanes);
        for (int k = 0; k < GROUPS; k++) {
            stiff[k] = load(stiffness + j + k * LANES);
            later[k] = (1.0 - alpha_f) * stiff[k];
            top[k] = energy_per_mass(u[0][k], u[1][k], v[0][k], v[1][k], stiff[k], L2);
        }
        for (ptrdiff_t i = 0; i < n; i++) {
            vec start[2][GROUPS], z[2][GROUPS], rest[2][GROUPS];
            for (int k = 0; k < GROUPS; k++) {
                vec force = alpha_f * stiff[k] * (u[0][k] * u[0][k] + u[1][k] * u[1][k] - L2);
                for (int r = 0; r < 2; r++) {
                    start[r][k] = u[r][k] + h * v[r][k] + h * h * (0.5 - beta) * a[r][k];
                    z[r][k] = (u[r][k] - start[r][k]) * inverse;
                    rest[r][k] = alpha_m * a[r][k] + force * u[r][k];
                }
            }
            int good = balance(z, start, all(c), later, L2, all(tolerance), 1.0 - alpha_m, rest);
            for (int k = 0; k < GROUPS; k++) {
                for (int r = 0; r < 2; r++) {
                    v[r][k] += h * ((1.0 - gamma) * a[r][k] + gamma * z[r][k]);
                    u[r][k] = start[r][k] + c * z[r][k];
                    a[r][k] = z[r][k];
                }
                top[k] = largest(top[k], energy_per_mass(u[0][k], u[1][k], v[0][k], v[1][k], stiff[k], L2));
            }
            if (!good) {
                if (i < done) done = i;
                break;
            }
        }
        write_vector(u, state + j, lanes), write_vector(v, state + 2 * lanes + j, lanes);
        write_vector(a, state + 4 * lanes + j, lanes);
        for (int k = 0; k < GROUPS; k++) store(peak + j + k * LANES, top[k]);
    }
    return done;
}
