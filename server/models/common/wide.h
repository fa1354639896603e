/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Short vectors of ss_real, so that a kernel is written once and compiled for every processor.
 *
 * ss_quad is one node: x y z and a fourth lane; ss_pair is two nodes. ss_wide is as many scalars as
 * the processor takes at once (SS_WIDE_LANES), with the language's own + - * /. What the compiler
 * is told decides: -mavx2 -mfma gives 256-bit vectors and fused multiply-add, baseline x86-64 gives
 * SSE2 without, SOFTSIM_SCALAR or any other processor plain C. Only ss_*_fma and ss_*_fnma fuse,
 * and only where they are written: results depend on the path, never on what a compiler happens to
 * contract. Kernels include this header; nothing else does. RT-safe throughout.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "rt/real.h"

#if !defined(SOFTSIM_SCALAR) && defined(__AVX2__) && defined(__FMA__)
#define SS_WIDE_AVX2 1
#include <immintrin.h>
#elif !defined(SOFTSIM_SCALAR) && defined(__SSE2__)
#define SS_WIDE_SSE2 1
#include <emmintrin.h>
#endif

#define SS_INLINE static inline __attribute__((always_inline))

/* SS_KERNEL_TABLE(ss_x_kernels, .function = function, ...) at the end of a source of kernels is its
 * table for the path that it is compiled for; dispatch.h chooses among them. */
#ifdef SS_WIDE_AVX2
#define SS_KERNELS_HERE(kernels) kernels##_avx2
#define SS_KERNELS_NAME          "avx2+fma"
#else
#define SS_KERNELS_HERE(kernels) kernels##_baseline
#ifdef SS_WIDE_SSE2
#define SS_KERNELS_NAME "sse2"
#else
#define SS_KERNELS_NAME "plain C"
#endif
#endif
#define SS_KERNEL_TABLE(kernels, ...)                                                              \
    extern const kernels SS_KERNELS_HERE(kernels);                                                 \
    const kernels SS_KERNELS_HERE(kernels) = {.name = SS_KERNELS_NAME, __VA_ARGS__}

/* ---- quads ---- */

#if (defined(SS_WIDE_AVX2) || defined(SS_WIDE_SSE2)) && !defined(SOFTSIM_DOUBLE)

typedef __m128 ss_quad;

SS_INLINE ss_quad ss_quad_load(const ss_real *p)
{
    return _mm_load_ps(p);
}
SS_INLINE void ss_quad_store(ss_real *p, ss_quad a)
{
    _mm_store_ps(p, a);
}
SS_INLINE ss_quad ss_quad_all(ss_real s)
{
    return _mm_set1_ps(s);
}
SS_INLINE ss_quad ss_quad_add(ss_quad a, ss_quad b)
{
    return _mm_add_ps(a, b);
}
SS_INLINE ss_quad ss_quad_sub(ss_quad a, ss_quad b)
{
    return _mm_sub_ps(a, b);
}
SS_INLINE ss_quad ss_quad_mul(ss_quad a, ss_quad b)
{
    return _mm_mul_ps(a, b);
}
/* a b + c */
SS_INLINE ss_quad ss_quad_fma(ss_quad a, ss_quad b, ss_quad c)
{
#ifdef SS_WIDE_AVX2
    return _mm_fmadd_ps(a, b, c);
#else
    return _mm_add_ps(_mm_mul_ps(a, b), c);
#endif
}
/* c - a b */
SS_INLINE ss_quad ss_quad_fnma(ss_quad a, ss_quad b, ss_quad c)
{
#ifdef SS_WIDE_AVX2
    return _mm_fnmadd_ps(a, b, c);
#else
    return _mm_sub_ps(c, _mm_mul_ps(a, b));
#endif
}
/* The larger, the smaller of each lane; b's where a is not a number. */
SS_INLINE ss_quad ss_quad_most(ss_quad a, ss_quad b)
{
    return _mm_max_ps(a, b);
}
SS_INLINE ss_quad ss_quad_div(ss_quad a, ss_quad b)
{
    return _mm_div_ps(a, b);
}
SS_INLINE ss_quad ss_quad_root(ss_quad a)
{
    return _mm_sqrt_ps(a);
}
SS_INLINE ss_quad ss_quad_least(ss_quad a, ss_quad b)
{
    return _mm_min_ps(a, b);
}
/* The fourth lane 0. */
SS_INLINE ss_quad ss_quad_xyz(ss_quad a)
{
    return _mm_and_ps(a, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)));
}
/* Is a > b in any lane? */
SS_INLINE int ss_quad_is_any_above(ss_quad a, ss_quad b)
{
    return _mm_movemask_ps(_mm_cmpgt_ps(a, b));
}
/* The fourth lane, lane 0..3 (a constant), in all four. */
SS_INLINE ss_quad ss_quad_last(ss_quad a)
{
    return _mm_shuffle_ps(a, a, 0xff);
}
SS_INLINE ss_quad ss_quad_lane(ss_quad a, int lane)
{
    return lane == 0   ? _mm_shuffle_ps(a, a, 0x00)
           : lane == 1 ? _mm_shuffle_ps(a, a, 0x55)
           : lane == 2 ? _mm_shuffle_ps(a, a, 0xaa)
                       : _mm_shuffle_ps(a, a, 0xff);
}
/* Four rows become four columns. */
SS_INLINE void ss_quad_transpose(ss_quad *a, ss_quad *b, ss_quad *c, ss_quad *d)
{
    _MM_TRANSPOSE4_PS(*a, *b, *c, *d);
}

#elif defined(SS_WIDE_AVX2)

typedef __m256d ss_quad;

SS_INLINE ss_quad ss_quad_load(const ss_real *p)
{
    return _mm256_load_pd(p);
}
SS_INLINE void ss_quad_store(ss_real *p, ss_quad a)
{
    _mm256_store_pd(p, a);
}
SS_INLINE ss_quad ss_quad_all(ss_real s)
{
    return _mm256_set1_pd(s);
}
SS_INLINE ss_quad ss_quad_add(ss_quad a, ss_quad b)
{
    return _mm256_add_pd(a, b);
}
SS_INLINE ss_quad ss_quad_sub(ss_quad a, ss_quad b)
{
    return _mm256_sub_pd(a, b);
}
SS_INLINE ss_quad ss_quad_mul(ss_quad a, ss_quad b)
{
    return _mm256_mul_pd(a, b);
}
SS_INLINE ss_quad ss_quad_fma(ss_quad a, ss_quad b, ss_quad c)
{
    return _mm256_fmadd_pd(a, b, c);
}
SS_INLINE ss_quad ss_quad_fnma(ss_quad a, ss_quad b, ss_quad c)
{
    return _mm256_fnmadd_pd(a, b, c);
}
SS_INLINE ss_quad ss_quad_most(ss_quad a, ss_quad b)
{
    return _mm256_max_pd(a, b);
}
SS_INLINE ss_quad ss_quad_div(ss_quad a, ss_quad b)
{
    return _mm256_div_pd(a, b);
}
SS_INLINE ss_quad ss_quad_root(ss_quad a)
{
    return _mm256_sqrt_pd(a);
}
SS_INLINE ss_quad ss_quad_least(ss_quad a, ss_quad b)
{
    return _mm256_min_pd(a, b);
}
SS_INLINE ss_quad ss_quad_xyz(ss_quad a)
{
    return _mm256_blend_pd(a, _mm256_setzero_pd(), 8);
}
SS_INLINE int ss_quad_is_any_above(ss_quad a, ss_quad b)
{
    return _mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_GT_OQ));
}
SS_INLINE ss_quad ss_quad_last(ss_quad a)
{
    return _mm256_permute4x64_pd(a, 0xff);
}
SS_INLINE ss_quad ss_quad_lane(ss_quad a, int lane)
{
    return lane == 0   ? _mm256_permute4x64_pd(a, 0x00)
           : lane == 1 ? _mm256_permute4x64_pd(a, 0x55)
           : lane == 2 ? _mm256_permute4x64_pd(a, 0xaa)
                       : _mm256_permute4x64_pd(a, 0xff);
}
SS_INLINE void ss_quad_transpose(ss_quad *a, ss_quad *b, ss_quad *c, ss_quad *d)
{
    const __m256d t0 = _mm256_unpacklo_pd(*a, *b), t1 = _mm256_unpackhi_pd(*a, *b);
    const __m256d t2 = _mm256_unpacklo_pd(*c, *d), t3 = _mm256_unpackhi_pd(*c, *d);
    *a = _mm256_permute2f128_pd(t0, t2, 0x20);
    *b = _mm256_permute2f128_pd(t1, t3, 0x20);
    *c = _mm256_permute2f128_pd(t0, t2, 0x31);
    *d = _mm256_permute2f128_pd(t1, t3, 0x31);
}

#else /* plain C; double without AVX too */

typedef struct ss_quad {
    ss_real lane[4];
} ss_quad;

#define SS_QUAD_MAP(expression)                                                                    \
    ss_quad out;                                                                                   \
    for (int k = 0; k < 4; ++k) {                                                                  \
        out.lane[k] = (expression);                                                                \
    }                                                                                              \
    return out

SS_INLINE ss_quad ss_quad_load(const ss_real *p)
{
    SS_QUAD_MAP(p[k]);
}
SS_INLINE void ss_quad_store(ss_real *p, ss_quad a)
{
    for (int k = 0; k < 4; ++k) {
        p[k] = a.lane[k];
    }
}
SS_INLINE ss_quad ss_quad_all(ss_real s)
{
    SS_QUAD_MAP(s);
}
SS_INLINE ss_quad ss_quad_add(ss_quad a, ss_quad b)
{
    SS_QUAD_MAP(a.lane[k] + b.lane[k]);
}
SS_INLINE ss_quad ss_quad_sub(ss_quad a, ss_quad b)
{
    SS_QUAD_MAP(a.lane[k] - b.lane[k]);
}
SS_INLINE ss_quad ss_quad_mul(ss_quad a, ss_quad b)
{
    SS_QUAD_MAP(a.lane[k] * b.lane[k]);
}
SS_INLINE ss_quad ss_quad_fma(ss_quad a, ss_quad b, ss_quad c)
{
    SS_QUAD_MAP(a.lane[k] * b.lane[k] + c.lane[k]);
}
SS_INLINE ss_quad ss_quad_fnma(ss_quad a, ss_quad b, ss_quad c)
{
    SS_QUAD_MAP(c.lane[k] - a.lane[k] * b.lane[k]);
}
SS_INLINE ss_quad ss_quad_most(ss_quad a, ss_quad b)
{
    SS_QUAD_MAP(a.lane[k] > b.lane[k] ? a.lane[k] : b.lane[k]);
}
SS_INLINE ss_quad ss_quad_div(ss_quad a, ss_quad b)
{
    SS_QUAD_MAP(a.lane[k] / b.lane[k]);
}
SS_INLINE ss_quad ss_quad_root(ss_quad a)
{
    SS_QUAD_MAP(sizeof(ss_real) == sizeof(float) ? (ss_real)sqrtf((float)a.lane[k])
                                                 : (ss_real)sqrt((double)a.lane[k]));
}
SS_INLINE ss_quad ss_quad_least(ss_quad a, ss_quad b)
{
    SS_QUAD_MAP(a.lane[k] < b.lane[k] ? a.lane[k] : b.lane[k]);
}
SS_INLINE ss_quad ss_quad_xyz(ss_quad a)
{
    SS_QUAD_MAP(k < 3 ? a.lane[k] : 0);
}
SS_INLINE int ss_quad_is_any_above(ss_quad a, ss_quad b)
{
    int any = 0;
    for (int k = 0; k < 4; ++k) {
        any |= a.lane[k] > b.lane[k];
    }
    return any;
}
SS_INLINE ss_quad ss_quad_last(ss_quad a)
{
    SS_QUAD_MAP(a.lane[3]);
}
SS_INLINE ss_quad ss_quad_lane(ss_quad a, int lane)
{
    SS_QUAD_MAP(a.lane[lane]);
}
SS_INLINE void ss_quad_transpose(ss_quad *a, ss_quad *b, ss_quad *c, ss_quad *d)
{
    ss_quad *const row[4] = {a, b, c, d};
    for (int i = 0; i < 4; ++i) {
        for (int j = i + 1; j < 4; ++j) {
            const ss_real t = row[i]->lane[j];
            row[i]->lane[j] = row[j]->lane[i];
            row[j]->lane[i] = t;
        }
    }
}
#undef SS_QUAD_MAP

#endif

/* The four lanes added up in double: at the end of a block of rows, never inside one. */
SS_INLINE double ss_quad_sum(ss_quad a)
{
    _Alignas(32) ss_real lane[4];
    ss_quad_store(lane, a);
    return ((double)lane[0] + (double)lane[1]) + ((double)lane[2] + (double)lane[3]);
}

/* ---- pairs ---- */

/* Two nodes side by side: one register where the processor has 256 bits and a node is four floats,
 * else two quads. */
#if defined(SS_WIDE_AVX2) && !defined(SOFTSIM_DOUBLE)

typedef __m256 ss_pair;

SS_INLINE ss_pair ss_pair_load(const ss_real *p)
{
    return _mm256_load_ps(p);
}
SS_INLINE void ss_pair_store(ss_real *p, ss_pair a)
{
    _mm256_store_ps(p, a);
}
SS_INLINE ss_pair ss_pair_all(ss_real s)
{
    return _mm256_set1_ps(s);
}
/* p[0] for the first node, p[1] for the second. */
SS_INLINE ss_pair ss_pair_each(const ss_real *p)
{
    const __m256 both = _mm256_castpd_ps(_mm256_broadcast_sd((const double *)(const void *)p));
    return _mm256_permutevar_ps(both, _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1));
}
SS_INLINE ss_pair ss_pair_add(ss_pair a, ss_pair b)
{
    return _mm256_add_ps(a, b);
}
SS_INLINE ss_pair ss_pair_sub(ss_pair a, ss_pair b)
{
    return _mm256_sub_ps(a, b);
}
SS_INLINE ss_pair ss_pair_mul(ss_pair a, ss_pair b)
{
    return _mm256_mul_ps(a, b);
}
SS_INLINE ss_pair ss_pair_fma(ss_pair a, ss_pair b, ss_pair c)
{
    return _mm256_fmadd_ps(a, b, c);
}
SS_INLINE ss_pair ss_pair_fnma(ss_pair a, ss_pair b, ss_pair c)
{
    return _mm256_fnmadd_ps(a, b, c);
}
SS_INLINE ss_pair ss_pair_most(ss_pair a, ss_pair b)
{
    return _mm256_max_ps(a, b);
}
SS_INLINE ss_pair ss_pair_least(ss_pair a, ss_pair b)
{
    return _mm256_min_ps(a, b);
}
SS_INLINE ss_pair ss_pair_div(ss_pair a, ss_pair b)
{
    return _mm256_div_ps(a, b);
}
/* Each node's fourth lane in all four of it. */
SS_INLINE ss_pair ss_pair_last(ss_pair a)
{
    return _mm256_permute_ps(a, 0xff);
}
/* Each node's lane 0..3 (a constant) in all four of it. */
SS_INLINE ss_pair ss_pair_lane(ss_pair a, int lane)
{
    return lane == 0   ? _mm256_permute_ps(a, 0x00)
           : lane == 1 ? _mm256_permute_ps(a, 0x55)
           : lane == 2 ? _mm256_permute_ps(a, 0xaa)
                       : _mm256_permute_ps(a, 0xff);
}
SS_INLINE ss_pair ss_pair_xyz(ss_pair a)
{
    return _mm256_blend_ps(a, _mm256_setzero_ps(), 0x88);
}
/* Two nodes side by side, from where quads may be. */
SS_INLINE ss_pair ss_pair_load_quads(const ss_real *p)
{
    return _mm256_loadu_ps(p);
}
/* Eight scalars from anywhere. */
SS_INLINE ss_pair ss_pair_load_any(const ss_real *p)
{
    return _mm256_loadu_ps(p);
}
SS_INLINE ss_pair ss_pair_twice(ss_quad a)
{
    return _mm256_set_m128(a, a);
}
/* Two nodes that lie apart. */
SS_INLINE ss_pair ss_pair_join(const ss_real *p, const ss_real *q)
{
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(p)), _mm_load_ps(q), 1);
}
SS_INLINE ss_quad ss_pair_first(ss_pair a)
{
    return _mm256_castps256_ps128(a);
}
SS_INLINE ss_quad ss_pair_second(ss_pair a)
{
    return _mm256_extractf128_ps(a, 1);
}
SS_INLINE ss_pair ss_pair_root(ss_pair a)
{
    return _mm256_sqrt_ps(a);
}
SS_INLINE int ss_pair_is_any_above(ss_pair a, ss_pair b)
{
    return _mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_GT_OQ));
}
/* Each half by itself: four rows become four columns. */
SS_INLINE void ss_pair_transpose(ss_pair *a, ss_pair *b, ss_pair *c, ss_pair *d)
{
    const __m256 t0 = _mm256_unpacklo_ps(*a, *b), t1 = _mm256_unpackhi_ps(*a, *b);
    const __m256 t2 = _mm256_unpacklo_ps(*c, *d), t3 = _mm256_unpackhi_ps(*c, *d);
    *a = _mm256_shuffle_ps(t0, t2, 0x44);
    *b = _mm256_shuffle_ps(t0, t2, 0xee);
    *c = _mm256_shuffle_ps(t1, t3, 0x44);
    *d = _mm256_shuffle_ps(t1, t3, 0xee);
}
/* One node after the other, added up. */
SS_INLINE ss_quad ss_pair_both(ss_pair a)
{
    return _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
}
SS_INLINE double ss_pair_sum(ss_pair a)
{
    return ss_quad_sum(ss_pair_both(a));
}
SS_INLINE ss_quad ss_pair_fold(ss_pair a) /* the larger node's value of each lane */
{
    return _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
}

#else

typedef struct ss_pair {
    ss_quad first, second;
} ss_pair;

SS_INLINE ss_pair ss_pair_load(const ss_real *p)
{
    return (ss_pair){ss_quad_load(p), ss_quad_load(p + 4)};
}
SS_INLINE void ss_pair_store(ss_real *p, ss_pair a)
{
    ss_quad_store(p, a.first);
    ss_quad_store(p + 4, a.second);
}
SS_INLINE ss_pair ss_pair_all(ss_real s)
{
    return (ss_pair){ss_quad_all(s), ss_quad_all(s)};
}
SS_INLINE ss_pair ss_pair_each(const ss_real *p)
{
    return (ss_pair){ss_quad_all(p[0]), ss_quad_all(p[1])};
}
SS_INLINE ss_pair ss_pair_add(ss_pair a, ss_pair b)
{
    return (ss_pair){ss_quad_add(a.first, b.first), ss_quad_add(a.second, b.second)};
}
SS_INLINE ss_pair ss_pair_sub(ss_pair a, ss_pair b)
{
    return (ss_pair){ss_quad_sub(a.first, b.first), ss_quad_sub(a.second, b.second)};
}
SS_INLINE ss_pair ss_pair_mul(ss_pair a, ss_pair b)
{
    return (ss_pair){ss_quad_mul(a.first, b.first), ss_quad_mul(a.second, b.second)};
}
SS_INLINE ss_pair ss_pair_fma(ss_pair a, ss_pair b, ss_pair c)
{
    return (ss_pair){ss_quad_fma(a.first, b.first, c.first),
                     ss_quad_fma(a.second, b.second, c.second)};
}
SS_INLINE ss_pair ss_pair_fnma(ss_pair a, ss_pair b, ss_pair c)
{
    return (ss_pair){ss_quad_fnma(a.first, b.first, c.first),
                     ss_quad_fnma(a.second, b.second, c.second)};
}
SS_INLINE ss_pair ss_pair_most(ss_pair a, ss_pair b)
{
    return (ss_pair){ss_quad_most(a.first, b.first), ss_quad_most(a.second, b.second)};
}
SS_INLINE ss_pair ss_pair_least(ss_pair a, ss_pair b)
{
    return (ss_pair){ss_quad_least(a.first, b.first), ss_quad_least(a.second, b.second)};
}
SS_INLINE ss_pair ss_pair_div(ss_pair a, ss_pair b)
{
    return (ss_pair){ss_quad_div(a.first, b.first), ss_quad_div(a.second, b.second)};
}
SS_INLINE ss_pair ss_pair_last(ss_pair a)
{
    return (ss_pair){ss_quad_last(a.first), ss_quad_last(a.second)};
}
SS_INLINE ss_pair ss_pair_lane(ss_pair a, int lane)
{
    return (ss_pair){ss_quad_lane(a.first, lane), ss_quad_lane(a.second, lane)};
}
SS_INLINE ss_pair ss_pair_xyz(ss_pair a)
{
    return (ss_pair){ss_quad_xyz(a.first), ss_quad_xyz(a.second)};
}
SS_INLINE ss_pair ss_pair_load_quads(const ss_real *p)
{
    return ss_pair_load(p);
}
SS_INLINE ss_pair ss_pair_load_any(const ss_real *p)
{
    _Alignas(32) ss_real lane[8];
    memcpy(lane, p, sizeof lane);
    return ss_pair_load(lane);
}
SS_INLINE ss_pair ss_pair_twice(ss_quad a)
{
    return (ss_pair){a, a};
}
SS_INLINE ss_pair ss_pair_join(const ss_real *p, const ss_real *q)
{
    return (ss_pair){ss_quad_load(p), ss_quad_load(q)};
}
SS_INLINE ss_quad ss_pair_first(ss_pair a)
{
    return a.first;
}
SS_INLINE ss_quad ss_pair_second(ss_pair a)
{
    return a.second;
}
SS_INLINE ss_pair ss_pair_root(ss_pair a)
{
    return (ss_pair){ss_quad_root(a.first), ss_quad_root(a.second)};
}
SS_INLINE int ss_pair_is_any_above(ss_pair a, ss_pair b)
{
    return ss_quad_is_any_above(a.first, b.first) | ss_quad_is_any_above(a.second, b.second);
}
SS_INLINE void ss_pair_transpose(ss_pair *a, ss_pair *b, ss_pair *c, ss_pair *d)
{
    ss_quad_transpose(&a->first, &b->first, &c->first, &d->first);
    ss_quad_transpose(&a->second, &b->second, &c->second, &d->second);
}
SS_INLINE ss_quad ss_pair_both(ss_pair a)
{
    return ss_quad_add(a.first, a.second);
}
SS_INLINE double ss_pair_sum(ss_pair a)
{
    return ss_quad_sum(ss_pair_both(a));
}
SS_INLINE ss_quad ss_pair_fold(ss_pair a)
{
    return ss_quad_most(a.first, a.second);
}

#endif

/* ---- wide ---- */

#if defined(SS_WIDE_AVX2) && !defined(SOFTSIM_DOUBLE)
#define SS_WIDE_LANES 8
typedef __m256 ss_wide;
#define SS_WIDE_OP(name) _mm256_##name##_ps
#elif defined(SS_WIDE_AVX2)
#define SS_WIDE_LANES    4
typedef __m256d ss_wide;
#define SS_WIDE_OP(name) _mm256_##name##_pd
#elif defined(SS_WIDE_SSE2) && !defined(SOFTSIM_DOUBLE)
#define SS_WIDE_LANES    4
typedef __m128 ss_wide;
#define SS_WIDE_OP(name) _mm_##name##_ps
#elif defined(SS_WIDE_SSE2)
#define SS_WIDE_LANES    2
typedef __m128d ss_wide;
#define SS_WIDE_OP(name) _mm_##name##_pd
#else
#define SS_WIDE_LANES 1
typedef ss_real ss_wide;
#endif

#ifdef SS_WIDE_OP
SS_INLINE ss_wide ss_wide_load(const ss_real *p)
{
    return SS_WIDE_OP(load)(p);
}
SS_INLINE void ss_wide_store(ss_real *p, ss_wide a)
{
    SS_WIDE_OP(store)(p, a);
}
SS_INLINE ss_wide ss_wide_all(ss_real s)
{
    return SS_WIDE_OP(set1)(s);
}
/* a b + c */
SS_INLINE ss_wide ss_wide_fma(ss_wide a, ss_wide b, ss_wide c)
{
#ifdef SS_WIDE_AVX2
    return SS_WIDE_OP(fmadd)(a, b, c);
#else
    return SS_WIDE_OP(add)(SS_WIDE_OP(mul)(a, b), c);
#endif
}
/* The larger of each lane; b's where a is not a number. */
SS_INLINE ss_wide ss_wide_most(ss_wide a, ss_wide b)
{
    return SS_WIDE_OP(max)(a, b);
}
SS_INLINE ss_wide ss_wide_root(ss_wide a)
{
    return SS_WIDE_OP(sqrt)(a);
}
/* c - a b */
SS_INLINE ss_wide ss_wide_fnma(ss_wide a, ss_wide b, ss_wide c)
{
#ifdef SS_WIDE_AVX2
    return SS_WIDE_OP(fnmadd)(a, b, c);
#else
    return SS_WIDE_OP(sub)(c, SS_WIDE_OP(mul)(a, b));
#endif
}
/* a where x < limit, else b. */
SS_INLINE ss_wide ss_wide_below(ss_wide x, ss_wide limit, ss_wide a, ss_wide b)
{
#ifdef SS_WIDE_AVX2
#ifdef SOFTSIM_DOUBLE
    return _mm256_blendv_pd(b, a, _mm256_cmp_pd(x, limit, _CMP_LT_OQ));
#else
    return _mm256_blendv_ps(b, a, _mm256_cmp_ps(x, limit, _CMP_LT_OQ));
#endif
#else
    const ss_wide mask = SS_WIDE_OP(cmplt)(x, limit);
    return SS_WIDE_OP(or)(SS_WIDE_OP(and)(mask, a), SS_WIDE_OP(andnot)(mask, b));
#endif
}
/* Is x < limit in any lane? */
SS_INLINE bool ss_wide_any_below(ss_wide x, ss_wide limit)
{
#ifdef SS_WIDE_AVX2
#ifdef SOFTSIM_DOUBLE
    return _mm256_movemask_pd(_mm256_cmp_pd(x, limit, _CMP_LT_OQ)) != 0;
#else
    return _mm256_movemask_ps(_mm256_cmp_ps(x, limit, _CMP_LT_OQ)) != 0;
#endif
#else
    return SS_WIDE_OP(movemask)(SS_WIDE_OP(cmplt)(x, limit)) != 0;
#endif
}
#undef SS_WIDE_OP
#else
SS_INLINE ss_wide ss_wide_most(ss_wide a, ss_wide b)
{
    return a > b ? a : b;
}
SS_INLINE ss_wide ss_wide_root(ss_wide a)
{
    return (ss_wide)sqrt((double)a);
}
SS_INLINE ss_wide ss_wide_fnma(ss_wide a, ss_wide b, ss_wide c)
{
    return c - a * b;
}
SS_INLINE ss_wide ss_wide_below(ss_wide x, ss_wide limit, ss_wide a, ss_wide b)
{
    return x < limit ? a : b;
}
SS_INLINE bool ss_wide_any_below(ss_wide x, ss_wide limit)
{
    return x < limit;
}
SS_INLINE ss_wide ss_wide_load(const ss_real *p)
{
    return *p;
}
SS_INLINE void ss_wide_store(ss_real *p, ss_wide a)
{
    *p = a;
}
SS_INLINE ss_wide ss_wide_all(ss_real s)
{
    return s;
}
SS_INLINE ss_wide ss_wide_fma(ss_wide a, ss_wide b, ss_wide c)
{
    return a * b + c;
}
#endif

/* The lanes added up in double, at the end of a block. */
SS_INLINE double ss_wide_sum(ss_wide a)
{
    _Alignas(32) ss_real lane[SS_WIDE_LANES];
    ss_wide_store(lane, a);
    double sum = 0.0;
    for (int k = 0; k < SS_WIDE_LANES; ++k) {
        sum += (double)lane[k];
    }
    return sum;
}

/* Nodes to lanes and back: SS_WIDE_LANES quads at offsets `at` from `p` become x, y and z of as
 * many lanes; adding them back goes quad by quad, so that one offset may stand twice. */
#if defined(SS_WIDE_AVX2) && !defined(SOFTSIM_DOUBLE)

SS_INLINE void ss_wide_gather(const ss_real *p, const int32_t *at, ss_wide out[3])
{
    const __m256 a = _mm256_set_m128(_mm_load_ps(p + at[4]), _mm_load_ps(p + at[0]));
    const __m256 b = _mm256_set_m128(_mm_load_ps(p + at[5]), _mm_load_ps(p + at[1]));
    const __m256 c = _mm256_set_m128(_mm_load_ps(p + at[6]), _mm_load_ps(p + at[2]));
    const __m256 d = _mm256_set_m128(_mm_load_ps(p + at[7]), _mm_load_ps(p + at[3]));
    const __m256 ab = _mm256_unpacklo_ps(a, b), cd = _mm256_unpacklo_ps(c, d);
    out[0] = _mm256_shuffle_ps(ab, cd, 0x44);
    out[1] = _mm256_shuffle_ps(ab, cd, 0xee);
    out[2] = _mm256_shuffle_ps(_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d), 0x44);
}
SS_INLINE void ss_wide_add_two(ss_real *low, ss_real *high, __m256 both)
{
    _mm_store_ps(low, _mm_add_ps(_mm_load_ps(low), _mm256_castps256_ps128(both)));
    _mm_store_ps(high, _mm_add_ps(_mm_load_ps(high), _mm256_extractf128_ps(both, 1)));
}
SS_INLINE void ss_wide_scatter_add(ss_real *p, const int32_t *at, const ss_wide in[3])
{
    const __m256 zero = _mm256_setzero_ps();
    const __m256 xy = _mm256_unpacklo_ps(in[0], in[1]), z = _mm256_unpacklo_ps(in[2], zero);
    const __m256 xy2 = _mm256_unpackhi_ps(in[0], in[1]), z2 = _mm256_unpackhi_ps(in[2], zero);
    ss_wide_add_two(p + at[0], p + at[4], _mm256_shuffle_ps(xy, z, 0x44));
    ss_wide_add_two(p + at[1], p + at[5], _mm256_shuffle_ps(xy, z, 0xee));
    ss_wide_add_two(p + at[2], p + at[6], _mm256_shuffle_ps(xy2, z2, 0x44));
    ss_wide_add_two(p + at[3], p + at[7], _mm256_shuffle_ps(xy2, z2, 0xee));
}

#elif (defined(SS_WIDE_SSE2) && !defined(SOFTSIM_DOUBLE)) || defined(SS_WIDE_AVX2)

SS_INLINE void ss_wide_gather(const ss_real *p, const int32_t *at, ss_wide out[3])
{
    ss_quad fourth = ss_quad_load(p + at[3]);
    out[0] = ss_quad_load(p + at[0]);
    out[1] = ss_quad_load(p + at[1]);
    out[2] = ss_quad_load(p + at[2]);
    ss_quad_transpose(&out[0], &out[1], &out[2], &fourth);
}
SS_INLINE void ss_wide_scatter_add(ss_real *p, const int32_t *at, const ss_wide in[3])
{
    ss_quad row[4] = {in[0], in[1], in[2], ss_quad_all(0)};
    ss_quad_transpose(&row[0], &row[1], &row[2], &row[3]);
    for (int k = 0; k < 4; ++k) {
        ss_quad_store(p + at[k], ss_quad_add(ss_quad_load(p + at[k]), row[k]));
    }
}

#else

SS_INLINE void ss_wide_gather(const ss_real *p, const int32_t *at, ss_wide out[3])
{
    _Alignas(32) ss_real lane[3][SS_WIDE_LANES];
    for (int k = 0; k < SS_WIDE_LANES; ++k) {
        lane[0][k] = p[at[k]];
        lane[1][k] = p[at[k] + 1];
        lane[2][k] = p[at[k] + 2];
    }
    for (int c = 0; c < 3; ++c) {
        out[c] = ss_wide_load(lane[c]);
    }
}
SS_INLINE void ss_wide_scatter_add(ss_real *p, const int32_t *at, const ss_wide in[3])
{
    _Alignas(32) ss_real lane[3][SS_WIDE_LANES];
    for (int c = 0; c < 3; ++c) {
        ss_wide_store(lane[c], in[c]);
    }
    for (int k = 0; k < SS_WIDE_LANES; ++k) {
        p[at[k]] += lane[0][k];
        p[at[k] + 1] += lane[1][k];
        p[at[k] + 2] += lane[2][k];
    }
}

#endif
