// Many oscillators with a bilinear spring under one record, average acceleration: lanes inside, time outside.
#include "vectors.h"

// Per unit mass, S the force of the part that yields, times h^2/4, at most `limit`; A, B the stiffness beyond yielding
// and the rest of the initial one, both times h^2/4; F = h^2/4 (f_n + f_n+1), (n,). The balances at both ends add to
// (1 + c h/2 + A) du = h v + F - 2 A u - S0 - S1, of which the elastic trial is corrected by what exceeds the limit:
// there is no iteration. numbers (5, lanes): 1/(1 + c h/2 + A + B), 1/(1 + c h/2 + A), 2 A, B, limit; out (6, lanes):
// u, hv, S, peak |u|, and with ENERGY a quarter of what yielding dissipates and twice the largest energy, of B h^2 both.
#define MARCH(NAME, GROUPS, ENERGY)                                                                             \
    static ptrdiff_t NAME(ptrdiff_t j, ptrdiff_t lanes, ptrdiff_t n, const double *numbers, const double *F,    \
                          double *out) {                                                                        \
        for (; j + GROUPS * LANES <= lanes; j += GROUPS * LANES) {                                              \
            vec c[5][GROUPS], u[GROUPS], w[GROUPS], S[GROUPS], top[2][GROUPS], lost[GROUPS];                    \
            for (int g = 0; g < GROUPS; g++) {                                                                  \
                for (int e = 0; e < 5; e++) c[e][g] = load(numbers + e * lanes + j + g * LANES);                \
                u[g] = w[g] = S[g] = top[0][g] = top[1][g] = lost[g] = all(0.0);                                \
            }                                                                                                   \
            for (ptrdiff_t i = 0; i < n; i++) {                                                                 \
                vec f = all(F[i]);                                                                              \
                for (int g = 0; g < GROUPS; g++) {                                                              \
                    vec elastic = c[0][g] * (((w[g] + f) - c[2][g] * u[g]) - 2.0 * S[g]);                       \
                    vec trial = S[g] + c[3][g] * elastic;                                                       \
                    vec kept = largest(smallest(trial, c[4][g]), -c[4][g]);                                     \
                    vec du = elastic + c[1][g] * (trial - kept);                                                \
                    if (ENERGY) lost[g] += kept * ((S[g] + c[3][g] * du) - kept);                               \
                    u[g] += du, w[g] = 2.0 * du - w[g], S[g] = kept;                                            \
                    top[0][g] = largest(top[0][g], magnitude(u[g]));                                            \
                    if (ENERGY) {                                                                               \
                        vec motion = w[g] * w[g] + 2.0 * c[2][g] * (u[g] * u[g]);                               \
                        top[1][g] = largest(top[1][g], c[3][g] * motion + 4.0 * (S[g] * S[g]));                 \
                    }                                                                                           \
                }                                                                                               \
            }                                                                                                   \
            for (int g = 0; g < GROUPS; g++) {                                                                  \
                vec found[6] = {u[g], w[g], S[g], top[0][g], lost[g], top[1][g]};                               \
                for (int e = 0; e < 6; e++) store(out + e * lanes + j + g * LANES, found[e]);                   \
            }                                                                                                   \
        }                                                                                                       \
        return j;                                                                                               \
    }

// The same motion by the step that substep prints: u, v, a, the plastic part p, what is dissipated and the largest
// energy, f (n,) at the steps' ends. With s = 1/(1 + c h/2 + h^2/4 alpha k) and t = 1/(1 + c h/2 + h^2/4 k) numbers
// (13, lanes): h, h^2/4, c, s, s alpha k, s (1 - alpha) q_y, t, t (1 - alpha) k, t k, q_y/k, (1 - alpha) k,
// alpha k/2, (1 - alpha) k/2; out (6, lanes).
#define PRINTED(NAME, GROUPS)                                                                                   \
    static ptrdiff_t NAME(ptrdiff_t j, ptrdiff_t lanes, ptrdiff_t n, const double *numbers, const double *f,    \
                          double *out) {                                                                        \
        for (; j + GROUPS * LANES <= lanes; j += GROUPS * LANES) {                                              \
            vec c[13][GROUPS], u[GROUPS], v[GROUPS], a[GROUPS], p[GROUPS], lost[GROUPS], top[GROUPS];           \
            for (int g = 0; g < GROUPS; g++) {                                                                  \
                for (int e = 0; e < 13; e++) c[e][g] = load(numbers + e * lanes + j + g * LANES);               \
                u[g] = v[g] = a[g] = p[g] = lost[g] = top[g] = all(0.0);                                        \
            }                                                                                                   \
            for (ptrdiff_t i = 0; i < n; i++) {                                                                 \
                vec load = all(f[i]);                                                                           \
                for (int g = 0; g < GROUPS; g++) {                                                              \
                    vec h = c[0][g], quarter = c[1][g], half = 0.5 * h;                                         \
                    vec far = a[g] * quarter + h * v[g] + u[g], way = a[g] * half + v[g];                       \
                    vec r = c[2][g] * way - load, x = c[3][g] * r + c[4][g] * far;                              \
                    vec stuck = c[7][g] * p[g] - c[6][g] * r - c[8][g] * far;                                   \
                    vec a1 = largest(-c[5][g] - x, smallest(c[5][g] - x, stuck));                               \
                    vec u1 = a1 * quarter + far, v1 = a1 * half + way;                                          \
                    vec p1 = largest(u1 - c[9][g], smallest(u1 + c[9][g], p[g])), e = u1 - p1;                  \
                    lost[g] += c[10][g] * (p1 - p[g]) * e;                                                       \
                    vec energy = c[11][g] * (u1 * u1) + c[12][g] * (e * e) + 0.5 * (v1 * v1);                   \
                    top[g] = largest(top[g], energy);                                                           \
                    u[g] = u1, v[g] = v1, a[g] = a1, p[g] = p1;                                                 \
                }                                                                                               \
            }                                                                                                   \
            for (int g = 0; g < GROUPS; g++) {                                                                  \
                vec found[6] = {u[g], v[g], a[g], p[g], lost[g], top[g]};                                       \
                for (int e = 0; e < 6; e++) store(out + e * lanes + j + g * LANES, found[e]);                   \
            }                                                                                                   \
        }                                                                                                       \
        return j;                                                                                               \
    }

// as many groups of lanes in flight as are fastest, then pairs of groups for the lanes that are left
#define ENTRY(NAME, MANY, FEW)                                                                                   \
    void NAME(ptrdiff_t lanes, ptrdiff_t n, const double *numbers, const double *F, double *out) {               \
        FEW(MANY(0, lanes, n, numbers, F, out), lanes, n, numbers, F, out);                                      \
    }
MARCH(six, 6, 0)
MARCH(two, 2, 0)
MARCH(four_energy, 4, 1)
MARCH(two_energy, 2, 1)
ENTRY(bilinear, six, two)
ENTRY(bilinear_energy, four_energy, two_energy)
PRINTED(three_printed, 3)
PRINTED(one_printed, 1)
ENTRY(bilinear_printed, three_printed, one_printed)
