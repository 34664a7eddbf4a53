// Many linear oscillators under one record: lanes inside, time outside, everything in registers.
#include "vectors.h"

// Groups of LANES lanes in flight: as many as hide the latency of the recurrence and fit the registers.
#define MAP_GROUPS 4
#define COMPANION_GROUPS 6

// x1 = x0 + D x0 + B0 f_n + B1 f_n+1 in M variables, D (M, M, lanes), B0, B1 (M, lanes); peak of |x[0]|
#define MAP_MARCH(NAME, M, GROUPS)                                                                        \
    void NAME(ptrdiff_t lanes, ptrdiff_t n, const double *D, const double *B0, const double *B1,         \
              const double *f, double *peak) {                                                            \
        for (ptrdiff_t j = 0; j + GROUPS * LANES <= lanes; j += GROUPS * LANES) {                         \
            vec d[M][M][GROUPS], b0[M][GROUPS], b1[M][GROUPS], x[M][GROUPS], top[GROUPS];                 \
            for (int g = 0; g < GROUPS; g++) {                                                            \
                for (int r = 0; r < M; r++) {                                                             \
                    for (int c = 0; c < M; c++)                                                           \
                        d[r][c][g] = load(D + (r * M + c) * lanes + j + g * LANES) + (r == c ? 1.0 : 0.0); \
                    b0[r][g] = load(B0 + r * lanes + j + g * LANES);                                      \
                    b1[r][g] = load(B1 + r * lanes + j + g * LANES);                                      \
                    x[r][g] = all(0.0);                                                                   \
                }                                                                                         \
                top[g] = all(0.0);                                                                        \
            }                                                                                             \
            vec f0 = all(f[0]);                                                                           \
            for (ptrdiff_t i = 1; i <= n; i++) {                                                          \
                vec f1 = all(f[i]);                                                                       \
                for (int g = 0; g < GROUPS; g++) {                                                        \
                    vec y[M];                                                                             \
                    for (int r = 0; r < M; r++) {                                                         \
                        y[r] = b0[r][g] * f0 + b1[r][g] * f1;                                             \
                        for (int c = M - 1; c >= 0; c--) y[r] += d[r][c][g] * x[c][g];                    \
                    }                                                                                     \
                    for (int r = 0; r < M; r++) x[r][g] = y[r];                                           \
                    top[g] = largest(top[g], magnitude(x[0][g]));                                         \
                }                                                                                         \
                f0 = f1;                                                                                  \
            }                                                                                             \
            for (int g = 0; g < GROUPS; g++) store(peak + j + g * LANES, top[g]);                         \
        }                                                                                                 \
    }
MAP_MARCH(map_two, 2, MAP_GROUPS)
MAP_MARCH(map_three, 3, 2)

// The same march with peaks of |u|, |h v| and |h^2 a|, where a = f - damping*hv - stiffness*u; peaks (3, lanes)
void map_two_peaks(ptrdiff_t lanes, ptrdiff_t n, const double *D, const double *B0, const double *B1,
                   const double *damping, const double *stiffness, const double *f, double *peaks) {
    for (ptrdiff_t j = 0; j + MAP_GROUPS * LANES <= lanes; j += MAP_GROUPS * LANES) {
        vec d[4][MAP_GROUPS], b[4][MAP_GROUPS], k[2][MAP_GROUPS], x[2][MAP_GROUPS], top[3][MAP_GROUPS];
        for (int g = 0; g < MAP_GROUPS; g++) {
            ptrdiff_t at = j + g * LANES;
            for (int e = 0; e < 4; e++) d[e][g] = load(D + e * lanes + at) + (e % 3 == 0 ? 1.0 : 0.0);
            for (int e = 0; e < 2; e++) b[e][g] = load(B0 + e * lanes + at), b[2 + e][g] = load(B1 + e * lanes + at);
            k[0][g] = load(stiffness + at), k[1][g] = load(damping + at);
            x[0][g] = x[1][g] = all(0.0);
            top[0][g] = top[1][g] = all(0.0), top[2][g] = all(fabs(f[0]));
        }
        for (ptrdiff_t i = 1; i <= n; i++)
            for (int g = 0; g < MAP_GROUPS; g++) {
                vec u = d[0][g] * x[0][g] + (d[1][g] * x[1][g] + (b[0][g] * f[i - 1] + b[2][g] * f[i]));
                vec v = d[2][g] * x[0][g] + (d[3][g] * x[1][g] + (b[1][g] * f[i - 1] + b[3][g] * f[i]));
                vec a = f[i] - k[0][g] * u - k[1][g] * v;
                x[0][g] = u, x[1][g] = v;
                top[0][g] = largest(top[0][g], magnitude(u));
                top[1][g] = largest(top[1][g], magnitude(v));
                top[2][g] = largest(top[2][g], magnitude(a));
            }
        for (int g = 0; g < MAP_GROUPS; g++)
            for (int r = 0; r < 3; r++) store(peaks + r * lanes + j + g * LANES, top[r][g]);
    }
}

// Companion form in increments: four multiply-adds and one addition a step, u alone. C (5, lanes): det, P, c1, c0, S
void companion(ptrdiff_t lanes, ptrdiff_t n, const double *C, const double *f, double *peak) {
    for (ptrdiff_t j = 0; j + COMPANION_GROUPS * LANES <= lanes; j += COMPANION_GROUPS * LANES) {
        vec c[4][COMPANION_GROUPS], x[COMPANION_GROUPS], d[COMPANION_GROUPS], top[COMPANION_GROUPS];
        for (int g = 0; g < COMPANION_GROUPS; g++) {
            for (int e = 0; e < 4; e++) c[e][g] = load(C + e * lanes + j + g * LANES);
            x[g] = d[g] = top[g] = all(0.0);
        }
        for (ptrdiff_t i = 1; i <= n; i++) {
            vec f1 = all(f[i]);
            for (int g = 0; g < COMPANION_GROUPS; g++) {
                vec next = (c[0][g] * d[g] + f1) - c[1][g] * x[g];
                x[g] += next;
                vec y = x[g] + (c[2][g] * next + c[3][g] * d[g]);
                d[g] = next;
                top[g] = largest(top[g], magnitude(y));
            }
        }
        for (int g = 0; g < COMPANION_GROUPS; g++)
            store(peak + j + g * LANES, magnitude(load(C + 4 * lanes + j + g * LANES)) * top[g]);
    }
}
