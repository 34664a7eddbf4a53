// Stability functions of a scheme with two live eigenvalues, c2*lambda^2 - trace*lambda + det = 0, or with three.
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

#if EIGENVALUES == 2
#define POLYNOMIALS 4

// half the pair's trace, p = |1 - lambda|^2, q = 1 - |lambda|^2 and det = |lambda|^2 of the pair, all times scale;
// p and q keep the digits of a small step, det those of a large one; the real eigenvalue beside it, if any, as it is
INLINE void pair(const vec *c, vec *scale, vec *half, vec *p, vec *q, vec *det, vec *third) {
    *scale = c[0], *p = c[1], *q = c[2], *det = c[3], *third = all(0.0);
    *half = c[0] - 0.5 * (c[1] + c[2]);
}
#else
#define POLYNOMIALS 6

INLINE vec third_power(vec x, int sign) {  // x^(sign/3) within 4 %, by the exponent
    ivec third = (((ivec)x >> 32) * 0x55555556) >> 32;
    return (vec)((sign > 0 ? 0x2A9F7893 + third : 0x553EF0FF - third) << 32);
}

// a step of fourth order to the positive root of y^3 + 3 p y = size
INLINE vec closer(vec y, vec p, vec size) {
    vec f = y * (y * y + 3.0 * p) - size, slope = 3.0 * (y * y + p), bend = slope * slope - 3.0 * y * f;
    return y - f * bend / (slope * (bend - 3.0 * y * f) + f * f + 1e-300);
}

// the real root farthest from the other two
INLINE vec real_root(vec a2, vec a1, vec a0) {
    vec middle = a2 * (-1.0 / 3.0), p = (a1 + a2 * middle) * (1.0 / 3.0);
    vec value = ((middle + a2) * middle + a1) * middle + a0, size = magnitude(value);
    mask convex = less(p, all(0.0));
    vec k = third_power(size, -1);
    k = k * k;
    vec y2 = choose(convex, size * k * size * k - 3.0 * p, k * (1.0 + 9.0 * p * p * k * k));
    ivec bits = (ivec)y2 >> 1;
    vec y = choose(convex, (vec)(bits + 0x1FF6C8FE00000000LL), (vec)(0x5FE62FD000000000LL - bits));
    y = closer(closer(y, p, size), p, size);
    return choose(less(value, all(0.0)), middle + y, middle - y);
}

// c3, c2, c1, c0, the value at 1 and the slope there
INLINE void pair(const vec *c, vec *scale, vec *half, vec *p, vec *q, vec *det, vec *third) {
    vec inverse = 1.0 / c[0], a2 = c[1] * inverse, a1 = c[2] * inverse, a0 = c[3] * inverse;
    vec r = real_root(a2, a1, a0), m = 1.0 - r;
    vec safe = choose(less(magnitude(r), all(1e-300)), all(1.0), r), both = 1.0 / (safe * m);
    *p = c[4] * inverse * (both * safe);
    vec t = (c[5] * inverse - *p) * (both * safe);
    *q = t - *p;
    *half = 1.0 - 0.5 * t;
    vec forward = a1 + r * (a2 + r);
    *det = choose(less(magnitude(forward), r * r), -a0 * (both * m), forward);
    *scale = all(1.0), *third = magnitude(r);
}
#endif

INLINE vec spectral_radius(vec c, vec half, vec gap, vec det, vec third) {
    vec modulus = root(magnitude(choose(less(gap, all(0.0)), gap, det * c)));
    vec straight = choose(less(gap, all(0.0)), magnitude(half), all(0.0));
    return largest((straight + modulus) / c, third);
}

void radius(ptrdiff_t n, const double *const *in, double *rho) {
    for (ptrdiff_t i = 0; i + LANES <= n; i += LANES) {
        vec v[INPUTS], out[POLYNOMIALS], c, half, p, q, det, third;
        for (int k = 0; k < INPUTS; k++) v[k] = load(in[k] + i);
        polynomials(v, out);
        pair(out, &c, &half, &p, &q, &det, &third);
        vec sum = 0.5 * (p + q), gap = p * c - sum * sum;
        store(rho + i, spectral_radius(c, half, gap, det, third));
    }
}

void stability(ptrdiff_t n, const double *const *in, double *rho, double *damping, double *period) {
    for (ptrdiff_t i = 0; i + LANES <= n; i += LANES) {
        vec v[INPUTS], out[POLYNOMIALS], c, half, p, q, det, third;
        for (int k = 0; k < INPUTS; k++) v[k] = load(in[k] + i);
        polynomials(v, out);
        pair(out, &c, &half, &p, &q, &det, &third);
        vec sum = 0.5 * (p + q), gap = p * c - sum * sum;
        store(rho + i, spectral_radius(c, half, gap, det, third));
        vec r = 1.0 / c, y = -q * r;
        mask near = less(q, 0.5 * c);
        vec u = choose(near, 1.0 + y, det * r);
        vec theta = angle(root(gap), half);  // NaN where the eigenvalues are real
        vec damped = 1.0 - v[1] * v[1], scale = root(damped), both = 1.0 / (theta * damped);
        store(damping + i, -(0.5 * logarithm(u, y) * damped + v[1] * scale * theta) * both);
        store(period + i, v[0] * scale * damped * both - 1.0);
    }
}
