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
#define POLYNOMIALS 5

// half the pair's trace, p = |1 - lambda|^2, q = 1 - |lambda|^2 and det = |lambda|^2 of the pair, all times scale;
// p and q keep the digits of a small step, det those of a large one; the real eigenvalue beside it, if any, as it is
INLINE void pair(const vec *c, vec *scale, vec *half, vec *p, vec *q, vec *det, vec *third) {
    *scale = c[0], *p = c[1], *q = c[2], *det = c[4], *third = all(0.0);
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
    *scale = all(1.0), *third = r;
}
#endif

INLINE vec spectral_radius(vec c, vec half, vec gap, vec det, vec third) {
    vec modulus = root(magnitude(choose(less(gap, all(0.0)), gap, det * c)));
    vec straight = choose(less(gap, all(0.0)), magnitude(half), all(0.0));
    return largest((straight + modulus) / c, magnitude(third));
}

typedef struct {
    vec c, half, q, det, gap, third;
} spectrum;

INLINE spectrum eigenvalues(const vec *v, vec *rho) {
    spectrum s;
    vec out[POLYNOMIALS], p;
    polynomials(v, out);
    pair(out, &s.c, &s.half, &p, &s.q, &s.det, &s.third);
    vec sum = 0.5 * (p + s.q);
    s.gap = p * s.c - sum * sum;
    *rho = spectral_radius(s.c, s.half, s.gap, s.det, s.third);
    return s;
}

// numerical damping and period error; NaN where the eigenvalues are real
INLINE void far(const vec *v, spectrum s, vec *damping, vec *period) {
    vec r = 1.0 / s.c, y = -s.q * r;
    mask beside = less(s.q, 0.5 * s.c);
    vec u = choose(beside, 1.0 + y, s.det * r);
    vec theta = angle(root(s.gap), s.half);
    vec damped = 1.0 - v[1] * v[1], scale = root(damped), both = 1.0 / (theta * damped);
    *damping = -(0.5 * logarithm(u, y) * damped + v[1] * scale * theta) * both;
    *period = v[0] * scale * damped * both - 1.0;
}

// tanh of half the distance, in s, of the pair half + i root from the exact one, as substep's `_distance_from_exact`
INLINE void apart(const vec *v, const vec *pair, vec *re, vec *im) {
    vec half = pair[0], less = 0.5 * pair[1], modulus2 = pair[2], imaginary = pair[3], found[5];
    residual(v, found);
    vec cosine = root(1.0 - v[1] * v[1]);
    vec p0 = found[0], p1 = cosine * found[1], x = found[2], y = cosine * found[3], leading = found[4];
    vec m = 0.25 * (1.0 + 2.0 * half + modulus2);
    vec f0 = m * x - less, f1 = m * y + imaginary;
    vec h0 = m - 0.25 * (less * x - imaginary * y), h1 = -0.25 * (less * y + imaginary * x);
    vec g0 = f0 * h0 - f1 * h1, g1 = f0 * h1 + f1 * h0;
#if EIGENVALUES == 3
    vec third = pair[4], j0 = 1.0 + 0.5 * x - third * (1.0 - 0.5 * x), j1 = 0.5 * y + third * 0.5 * y, k0 = g0;
    g0 = g0 * j0 - g1 * j1, g1 = k0 * j1 + g1 * j0;
#endif
    vec scale = -0.5 * m * v[0] * v[0] * v[0] / (leading * (g0 * g0 + g1 * g1));
    *re = scale * (p0 * g0 + p1 * g1), *im = scale * (p1 * g0 - p0 * g1);
}

// numerical damping and period error as substep's `_errors_of_distance`
INLINE void near(const vec *v, vec re, vec im, vec *damping, vec *period) {
    vec scale = root(1.0 - v[1] * v[1]), x = re * re - im * im, y = 2.0 * re * im;
    vec u = 1.0 / 3.0 + 1.0 / 5.0 * x, w = 1.0 / 5.0 * y, t = u;
    u = 1.0 + x * u - y * w, w = x * w + y * t;
    vec growth = 2.0 * (re * u - im * w), shift = 2.0 * (re * w + im * u);
    vec both = 1.0 / (scale * (scale * v[0] + shift));
    *damping = -(growth * scale + v[1] * shift) * both;
    *period = -shift * scale * both;
}

// from trace and determinant where p or q is not small, as substep: large Omega keeps its digits
INLINE vec radius_of_all(const vec *v) {
#if EIGENVALUES == 2
    vec out[POLYNOMIALS];
    polynomials(v, out);
    vec c = out[0], p = out[1], q = out[2], half = out[3], det = out[4], sum = 0.5 * (p + q), some = 0.5 * magnitude(c);
    vec gap = choose(less(magnitude(p), some), p * c - sum * sum, det * c - half * half);
    return spectral_radius(c, half, gap, choose(less(magnitude(q), some), c - q, det), all(0.0));
#else
    vec rho;
    eigenvalues(v, &rho);
    return rho;
#endif
}

INLINE void loads(const double *const *in, ptrdiff_t i, vec *v) {
    for (int k = 0; k < INPUTS; k++) v[k] = load(in[k] + i);
}

void radius(ptrdiff_t n, const double *const *in, double *rho) {
    for (ptrdiff_t i = 0; i + LANES <= n; i += LANES) {
        vec v[INPUTS], modulus;
        loads(in, i, v);
        eigenvalues(v, &modulus);
        store(rho + i, modulus);
    }
}

// with the digits of substep, and its refusal: nonzero where Omega, xi or a radius is negative or not finite
int radius_same(ptrdiff_t n, const double *const *in, double *rho) {
    ivec refused = {0}, largest_number = (ivec)all(1.7976931348623157e308);
    for (ptrdiff_t i = 0; i + LANES <= n; i += LANES) {
        vec v[INPUTS];
        loads(in, i, v);
        vec modulus = radius_of_all(v);
        store(rho + i, modulus);
        refused |= (ivec)v[0] | (ivec)v[1] | (largest_number - (ivec)magnitude(v[0] + v[1] + modulus));
    }
    int64_t some = 0;
    for (int k = 0; k < LANES; k++) some |= refused[k];
    return some < 0;
}

void stability_far(ptrdiff_t n, const double *const *in, double *rho, double *damping, double *period) {
    for (ptrdiff_t i = 0; i + LANES <= n; i += LANES) {
        vec v[INPUTS], found[3];
        loads(in, i, v);
        far(v, eigenvalues(v, found), found + 1, found + 2);
        store(rho + i, found[0]), store(damping + i, found[1]), store(period + i, found[2]);
    }
}

#define BLOCK 1024

// lanes near Omega = 0 are packed, and their formula is split in two loops, whose iterations overlap
static void block(ptrdiff_t n, const double *const *in, ptrdiff_t first, double *rho, double *damping, double *period) {
    double packed[INPUTS + 5][BLOCK + LANES], between[2][BLOCK + LANES];
    mask small[BLOCK / LANES];
    ptrdiff_t size = 0, vectors = n / LANES;
    for (ptrdiff_t j = 0; j < vectors; j++) {
        ptrdiff_t i = first + LANES * j;
        vec v[INPUTS], found[3];
        loads(in, i, v);
        spectrum s = eigenvalues(v, found);
        store(rho + i, found[0]);
        small[j] = less(v[0], all(SMALL_OMEGA));
        if (count(small[j]) < LANES) {
            far(v, s, found + 1, found + 2);
            store(damping + i, found[1]), store(period + i, found[2]);
        }
        if (any(small[j])) {
            for (int k = 0; k < INPUTS; k++) pack(packed[k] + size, small[j], v[k]);
            vec r = 1.0 / s.c, less = -s.q * r, pair[] = {s.half * r, less, 1.0 + less, root(s.gap) * r, s.third};
            for (int k = 0; k < 5; k++) pack(packed[INPUTS + k] + size, small[j], pair[k]);
            size += count(small[j]);
        }
    }
    if (size == 0) return;
    for (ptrdiff_t i = 0; i < size; i += LANES) {
        vec v[INPUTS + 5], re, im;
        for (int k = 0; k < INPUTS + 5; k++) v[k] = load(packed[k] + i);
        apart(v, v + INPUTS, &re, &im);
        store(between[0] + i, re), store(between[1] + i, im);
    }
    for (ptrdiff_t i = 0; i < size; i += LANES) {
        vec v[2] = {load(packed[0] + i), load(packed[1] + i)}, found[2];
        near(v, load(between[0] + i), load(between[1] + i), found, found + 1);
        store(packed[0] + i, found[0]), store(packed[1] + i, found[1]);
    }
    size = 0;
    for (ptrdiff_t j = 0; j < vectors; j++) {
        double *d = damping + first + LANES * j, *p = period + first + LANES * j;
        store(d, unpack(packed[0] + size, small[j], load(d)));
        store(p, unpack(packed[1] + size, small[j], load(p)));
        size += count(small[j]);
    }
}

void stability(ptrdiff_t n, const double *const *in, double *rho, double *damping, double *period) {
    for (ptrdiff_t i = 0; i < n; i += BLOCK) block(n - i < BLOCK ? n - i : BLOCK, in, i, rho, damping, period);
}
