// Vectors of doubles as wide as the machine's registers, and the few operations GCC's extension lacks in C.
#pragma once
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define LANES 8
#elif defined(__AVX2__) && defined(__FMA__)
#define LANES 4
#else
#define LANES 2
#endif
#if LANES > 2
#include <immintrin.h>
#endif

typedef double vec __attribute__((vector_size(8 * LANES)));
typedef int64_t ivec __attribute__((vector_size(8 * LANES)));
typedef double unaligned_vec __attribute__((vector_size(8 * LANES), aligned(8)));

#define INLINE static inline __attribute__((always_inline))

INLINE vec load(const double *p) { return *(const unaligned_vec *)p; }
INLINE void store(double *p, vec x) { *(unaligned_vec *)p = x; }
INLINE vec all(double x) { return x - (vec){0}; }

#if LANES == 8
typedef __mmask8 mask;
INLINE mask less(vec a, vec b) { return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LT_OQ); }
INLINE vec choose(mask m, vec a, vec b) { return (vec)_mm512_mask_blend_pd(m, (__m512d)b, (__m512d)a); }
INLINE vec largest(vec a, vec b) { return (vec)_mm512_max_pd((__m512d)a, (__m512d)b); }
INLINE vec smallest(vec a, vec b) { return (vec)_mm512_min_pd((__m512d)a, (__m512d)b); }
INLINE vec magnitude(vec a) { return (vec)_mm512_abs_pd((__m512d)a); }
INLINE vec root(vec a) { return (vec)_mm512_sqrt_pd((__m512d)a); }
INLINE int any(mask m) { return m != 0; }
INLINE int count(mask m) { return __builtin_popcount(m); }
// the chosen lanes one after another, and back: whole vectors are written
INLINE void pack(double *p, mask m, vec a) { store(p, (vec)_mm512_maskz_compress_pd(m, (__m512d)a)); }
INLINE vec unpack(const double *p, mask m, vec a) {
    return (vec)_mm512_mask_expand_pd((__m512d)a, m, (__m512d)load(p));
}
INLINE void stream(double *p, vec a) { _mm512_stream_pd(p, (__m512d)a); }
INLINE void fence(void) { _mm_sfence(); }
#else
typedef ivec mask;
INLINE mask less(vec a, vec b) { return (mask)(a < b); }
INLINE vec choose(mask m, vec a, vec b) { return (vec)((m & (ivec)a) | (~m & (ivec)b)); }
INLINE vec largest(vec a, vec b) { return choose(less(b, a), a, b); }
INLINE vec smallest(vec a, vec b) { return choose(less(a, b), a, b); }
INLINE vec magnitude(vec a) { return (vec)((ivec)a & INT64_MAX); }
INLINE int any(mask m) {
    int64_t found = 0;
    for (int i = 0; i < LANES; i++) found |= m[i];
    return found != 0;
}
INLINE int count(mask m) {
    int found = 0;
    for (int i = 0; i < LANES; i++) found -= m[i];
    return found;
}
INLINE void pack(double *p, mask m, vec a) {
    for (int i = 0; i < LANES; p -= m[i++]) *p = a[i];
}
INLINE vec unpack(const double *p, mask m, vec a) {
    for (int i = 0; i < LANES; p -= m[i++]) a[i] = m[i] ? *p : a[i];
    return a;
}
#if LANES == 4
INLINE vec root(vec a) { return (vec)_mm256_sqrt_pd((__m256d)a); }
INLINE void stream(double *p, vec a) { _mm256_stream_pd(p, (__m256d)a); }
INLINE void fence(void) { _mm_sfence(); }
#else
INLINE vec root(vec a) {
    for (int i = 0; i < LANES; i++) a[i] = sqrt(a[i]);
    return a;
}
INLINE void stream(double *p, vec a) { store(p, a); }
INLINE void fence(void) {}
#endif
#endif
