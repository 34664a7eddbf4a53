// Stability functions of a scheme with two live eigenvalues, c2*lambda^2 - trace*lambda + det = 0.
// polynomials.h is printed from the derivation: the scheme's formulas are nowhere typed.
#include "vectors.h"

#define SQRT_HALF 0.70710678118654752440
#define LN2 0.69314718055994530942
#define HALF_PI 1.57079632679489661923
#define TAN_PI_8 0.41421356237309504880

#include "polynomials.h"

INLINE vec horner(vec x, const double *coefficients, int n) {
    vec sum = all(coefficients[n - 1]);
#pragma GCC unroll 16
    for (int i = n - 2; i >= 0; i--) sum = sum * x + coefficients[i];
    return sum;
}

// log(u), where u = 1 + y and y has the digits if u is near 1
INLINE vec logarithm(vec u, vec y) {
    ivec bits = (ivec)u - (ivec)all(SQRT_HALF);
    ivec exponent = bits >> 52;
    vec m = (vec)((bits & 0x000fffffffffffffLL) + (ivec)all(SQRT_HALF));
    vec k = __builtin_convertvector(exponent, vec);
    vec f = choose(less(magnitude(k), all(0.5)), y, m - 1.0);
    vec s = f / (2.0 + f), z = s * s;
    return k * LN2 + s * horner(z, LOG_POLYNOMIAL, LOG_TERMS);
}

// angle of (x, y), y >= 0, in [0, pi]
INLINE vec angle(vec y, vec x) {
    vec width = magnitude(x);
    mask low = less(y, TAN_PI_8 * width), high = less(width, TAN_PI_8 * y);
    vec above = choose(low, y, choose(high, -width, y - width));
    vec below = choose(low, width, choose(high, y, y + width));
    vec offset = choose(low, all(0.0), choose(high, all(HALF_PI), all(0.5 * HALF_PI)));
    vec t = above / below;
    vec first = offset + t * horner(t * t, ATAN_POLYNOMIAL, ATAN_TERMS);
    return choose(less(x, all(0.0)), 2 * HALF_PI - first, first);
}

// p = c2 - trace + det and q = c2 - det keep the digits of a small step, det those of a large one
INLINE vec spectral_radius(vec c2, vec p, vec q, vec det, vec *half, vec *gap) {
    vec sum = 0.5 * (p + q);
    *half = c2 - sum;
    *gap = p * c2 - sum * sum;
    vec r = 1.0 / c2;
    vec modulus = root(magnitude(choose(less(*gap, all(0.0)), *gap, det * c2)));
    vec straight = choose(less(*gap, all(0.0)), magnitude(*half), all(0.0));
    return (straight + modulus) * r;
}

void radius(ptrdiff_t n, const double *const *in, double *rho) {
    for (ptrdiff_t i = 0; i + LANES <= n; i += LANES) {
        vec v[INPUTS], c2, p, q, det, half, gap;
        for (int k = 0; k < INPUTS; k++) v[k] = load(in[k] + i);
        polynomials(v, &c2, &p, &q, &det);
        store(rho + i, spectral_radius(c2, p, q, det, &half, &gap));
    }
}

void stability(ptrdiff_t n, const double *const *in, double *rho, double *damping, double *period) {
    for (ptrdiff_t i = 0; i + LANES <= n; i += LANES) {
        vec v[INPUTS], c2, p, q, det, half, gap;
        for (int k = 0; k < INPUTS; k++) v[k] = load(in[k] + i);
        polynomials(v, &c2, &p, &q, &det);
        store(rho + i, spectral_radius(c2, p, q, det, &half, &gap));
        vec r = 1.0 / c2, y = -q * r;
        mask near = less(q, 0.5 * c2);
        vec u = choose(near, 1.0 + y, det * r);
        vec theta = angle(root(gap), half);  // NaN where the eigenvalues are real
        vec damped = 1.0 - v[1] * v[1], scale = root(damped), both = 1.0 / (theta * damped);
        store(damping + i, -(0.5 * logarithm(u, y) * damped + v[1] * scale * theta) * both);
        store(period + i, v[0] * scale * damped * both - 1.0);
    }
}
