// What writing costs: to memory already touched, past the caches and through them, and to fresh pages.
#include "vectors.h"

// out aligned to 64 bytes, n a multiple of LANES
void store_plain(ptrdiff_t n, double value, double *out) {
    for (ptrdiff_t i = 0; i < n; i += LANES) *(volatile vec *)(out + i) = all(value);
}

void store_stream(ptrdiff_t n, double value, double *out) {
    for (ptrdiff_t i = 0; i < n; i += LANES) stream(out + i, all(value));
    fence();
}

// History of u, hv and h^2 a of many lanes, out (n + 1, 3, lanes) aligned to 64 bytes, row 0 the caller's; the state
// (2, lanes) stays in the cache, the history goes past it
void history(ptrdiff_t lanes, ptrdiff_t n, const double *D, const double *B0, const double *B1, const double *damping,
             const double *stiffness, const double *f, double *state, double *out) {
    for (ptrdiff_t i = 1; i <= n; i++) {
        double *row = out + 3 * lanes * i;
        vec f0 = all(f[i - 1]), f1 = all(f[i]);
        for (ptrdiff_t j = 0; j < lanes; j += LANES) {
            vec x = load(state + j), y = load(state + lanes + j);
            vec u = x + (load(D + j) * x + load(D + lanes + j) * y + (load(B0 + j) * f0 + load(B1 + j) * f1));
            vec v = y + (load(D + 2 * lanes + j) * x + load(D + 3 * lanes + j) * y +
                         (load(B0 + lanes + j) * f0 + load(B1 + lanes + j) * f1));
            store(state + j, u);
            store(state + lanes + j, v);
            stream(row + j, u);
            stream(row + lanes + j, v);
            stream(row + 2 * lanes + j, f1 - load(damping + j) * v - load(stiffness + j) * u);
        }
    }
    fence();
}
