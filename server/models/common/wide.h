/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Short vectors of ss_real, so that a kernel is written once and compiled for every processor.
 *
 * ss_quad is one node: x y z and a fourth lane; ss_pair is two nodes. ss_wide is as many scalars as
 * the processor takes at once (SS_WIDE_LANES), with the language's own + - * /. What the compiler
 * is told decides: -mavx2 -mfma gives 256-bit vectors and fused multiply-add, baseline x86-64 gives
 * SSE2 without, SOFTSIM_SCALAR or any other processor plain C. Vectors of 512 bits were tried on
 * fem-quadratic and gave nothing. Only ss_*_fma and ss_*_fnma fuse,
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
 * table for the path that it is compiled for; dispatch.h chooses among them. With
 * SS_KERNEL_TABLE_512 in its place there is a third path: the same 256-bit vectors in the 32
 * registers of AVX-512VL, bit for bit the same results, for kernels that run out of sixteen: slab
 * of 4349 elements, of the time with AVX2 fem-quadratic 0.92, corotational 0.92, fem 0.96. */
#if defined(SS_WIDE_AVX2) && defined(__AVX512VL__)
#define SS_KERNELS_HERE(kernels) kernels##_avx512vl
#define SS_KERNELS_NAME          "avx512vl"
#elif defined(SS_WIDE_AVX2)
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
#define SS_KERNEL_TABLE_512(kernels, ...) SS_KERNEL_TABLE(kernels, __VA_ARGS__)

/* ---- vectors of every width ---- */

/* Lane by lane: loaded, stored, computed with; fma is a b + c, fnma is c - a b. */
#define SS_VECTOR(vector, fused, fused_negative)                                                   \
    SS_INLINE vector vector##_load(const ss_real *p)                                               \
    {                                                                                              \
        return *(const vector *)(const void *)p;                                                   \
    }                                                                                              \
    SS_INLINE void vector##_store(ss_real *p, vector a)                                            \
    {                                                                                              \
        *(vector *)(void *)p = a;                                                                  \
    }                                                                                              \
    SS_VECTOR_TWO(vector, add, a + b)                                                              \
    SS_VECTOR_TWO(vector, sub, a - b)                                                              \
    SS_VECTOR_TWO(vector, mul, (a) * (b))                                                          \
    SS_VECTOR_TWO(vector, div, a / b)                                                              \
    SS_INLINE vector vector##_fma(vector a, vector b, vector c)                                    \
    {                                                                                              \
        return fused;                                                                              \
    }                                                                                              \
    SS_INLINE vector vector##_fnma(vector a, vector b, vector c)                                   \
    {                                                                                              \
        return fused_negative;                                                                     \
    }
/* And by functions of the instruction set, op(name): the larger, the smaller of each lane (b's
 * where a is not a number), the root. */
#define SS_VECTOR_OPS(vector, op)                                                                  \
    SS_VECTOR_TWO(vector, most, op(max)(a, b))                                                     \
    SS_VECTOR_TWO(vector, least, op(min)(a, b))                                                    \
    SS_INLINE vector vector##_root(vector a)                                                       \
    {                                                                                              \
        return op(sqrt)(a);                                                                        \
    }
#define SS_VECTOR_TWO(vector, name, result)                                                        \
    SS_INLINE vector vector##_##name(vector a, vector b)                                           \
    {                                                                                              \
        return result;                                                                             \
    }
#ifdef SS_WIDE_AVX2
#define SS_VECTOR_FUSED(vector, op) SS_VECTOR(vector, op(fmadd)(a, b, c), op(fnmadd)(a, b, c))
#else
#define SS_VECTOR_FUSED(vector, op) SS_VECTOR(vector, (a) * (b) + c, c - (a) * (b))
#endif

/* ---- quads ---- */

/* The language's own vectors, so that one definition does for every processor; a function of the
 * instruction set where the compiler finds none by itself (SS_QUAD_OP, where it has one). */
typedef ss_real ss_quad __attribute__((vector_size(4 * sizeof(ss_real)), may_alias));

#if (defined(SS_WIDE_AVX2) || defined(SS_WIDE_SSE2)) && !defined(SOFTSIM_DOUBLE)
#define SS_QUAD_OP(name)    _mm_##name##_ps
#define SS_QUAD_ABOVE(a, b) _mm_cmpgt_ps(a, b)
#elif defined(SS_WIDE_AVX2)
#define SS_QUAD_OP(name)    _mm256_##name##_pd
#define SS_QUAD_ABOVE(a, b) _mm256_cmp_pd(a, b, _CMP_GT_OQ)
#endif

SS_VECTOR_FUSED(ss_quad, SS_QUAD_OP)
SS_INLINE ss_quad ss_quad_all(ss_real s)
{
    return (ss_quad){s, s, s, s};
}
#ifdef SS_QUAD_OP
SS_VECTOR_OPS(ss_quad, SS_QUAD_OP)
#else
SS_INLINE ss_quad ss_quad_most(ss_quad a, ss_quad b)
{
    for (int k = 0; k < 4; ++k) {
        a[k] = a[k] > b[k] ? a[k] : b[k];
    }
    return a;
}
SS_INLINE ss_quad ss_quad_least(ss_quad a, ss_quad b)
{
    for (int k = 0; k < 4; ++k) {
        a[k] = a[k] < b[k] ? a[k] : b[k];
    }
    return a;
}
SS_INLINE ss_quad ss_quad_root(ss_quad a)
{
    for (int k = 0; k < 4; ++k) {
        a[k] = sizeof(ss_real) == sizeof(float) ? (ss_real)sqrtf((float)a[k])
                                                : (ss_real)sqrt((double)a[k]);
    }
    return a;
}
#endif
/* The fourth lane 0. */
SS_INLINE ss_quad ss_quad_xyz(ss_quad a)
{
    return __builtin_shufflevector(a, (ss_quad){0}, 0, 1, 2, 7);
}
/* Is a > b in any lane? */
SS_INLINE int ss_quad_is_any_above(ss_quad a, ss_quad b)
{
#ifdef SS_QUAD_OP
    return SS_QUAD_OP(movemask)(SS_QUAD_ABOVE(a, b));
#else
    return a[0] > b[0] || a[1] > b[1] || a[2] > b[2] || a[3] > b[3];
#endif
}
/* Lane 0..3 (a constant), the fourth lane, in all four. */
SS_INLINE ss_quad ss_quad_lane(ss_quad a, int lane)
{
    return lane == 0   ? __builtin_shufflevector(a, a, 0, 0, 0, 0)
           : lane == 1 ? __builtin_shufflevector(a, a, 1, 1, 1, 1)
           : lane == 2 ? __builtin_shufflevector(a, a, 2, 2, 2, 2)
                       : __builtin_shufflevector(a, a, 3, 3, 3, 3);
}
SS_INLINE ss_quad ss_quad_last(ss_quad a)
{
    return ss_quad_lane(a, 3);
}
/* Four rows become four columns. */
SS_INLINE void ss_quad_transpose(ss_quad *a, ss_quad *b, ss_quad *c, ss_quad *d)
{
    const ss_quad t0 = __builtin_shufflevector(*a, *b, 0, 4, 1, 5);
    const ss_quad t1 = __builtin_shufflevector(*a, *b, 2, 6, 3, 7);
    const ss_quad t2 = __builtin_shufflevector(*c, *d, 0, 4, 1, 5);
    const ss_quad t3 = __builtin_shufflevector(*c, *d, 2, 6, 3, 7);
    *a = __builtin_shufflevector(t0, t2, 0, 1, 4, 5);
    *b = __builtin_shufflevector(t0, t2, 2, 3, 6, 7);
    *c = __builtin_shufflevector(t1, t3, 0, 1, 4, 5);
    *d = __builtin_shufflevector(t1, t3, 2, 3, 6, 7);
}

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

typedef ss_real ss_pair __attribute__((vector_size(8 * sizeof(ss_real)), may_alias));

#define SS_PAIR_OP(name) _mm256_##name##_ps
SS_VECTOR_FUSED(ss_pair, SS_PAIR_OP)
SS_VECTOR_OPS(ss_pair, SS_PAIR_OP)
/* Eight scalars from anywhere. */
SS_INLINE ss_pair ss_pair_load_any(const ss_real *p)
{
    ss_pair out;
    memcpy(&out, p, sizeof out);
    return out;
}
SS_INLINE ss_pair ss_pair_of(ss_quad first, ss_quad second)
{
    return _mm256_set_m128(second, first);
}
SS_INLINE ss_quad ss_pair_first(ss_pair a)
{
    return _mm256_castps256_ps128(a);
}
SS_INLINE ss_quad ss_pair_second(ss_pair a)
{
    return _mm256_extractf128_ps(a, 1);
}
SS_INLINE ss_pair ss_pair_all(ss_real s)
{
    return (ss_pair){s, s, s, s, s, s, s, s};
}
/* p[0] for the first node, p[1] for the second. */
SS_INLINE ss_pair ss_pair_each(const ss_real *p)
{
    const __m256 both = _mm256_castpd_ps(_mm256_broadcast_sd((const double *)(const void *)p));
    return _mm256_permutevar_ps(both, _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1));
}
SS_INLINE ss_pair ss_pair_xyz(ss_pair a)
{
    return __builtin_shufflevector(a, (ss_pair){0}, 0, 1, 2, 11, 4, 5, 6, 15);
}
SS_INLINE int ss_pair_is_any_above(ss_pair a, ss_pair b)
{
    return _mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_GT_OQ));
}
/* Each node's lane 0..3 (a constant) in all four of it. */
SS_INLINE ss_pair ss_pair_lane(ss_pair a, int lane)
{
    return lane == 0   ? __builtin_shufflevector(a, a, 0, 0, 0, 0, 4, 4, 4, 4)
           : lane == 1 ? __builtin_shufflevector(a, a, 1, 1, 1, 1, 5, 5, 5, 5)
           : lane == 2 ? __builtin_shufflevector(a, a, 2, 2, 2, 2, 6, 6, 6, 6)
                       : __builtin_shufflevector(a, a, 3, 3, 3, 3, 7, 7, 7, 7);
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

#else

typedef struct ss_pair {
    ss_quad first, second;
} ss_pair;

SS_INLINE ss_pair ss_pair_of(ss_quad first, ss_quad second)
{
    return (ss_pair){first, second};
}
SS_INLINE ss_quad ss_pair_first(ss_pair a)
{
    return a.first;
}
SS_INLINE ss_quad ss_pair_second(ss_pair a)
{
    return a.second;
}
SS_INLINE ss_pair ss_pair_load(const ss_real *p)
{
    return ss_pair_of(ss_quad_load(p), ss_quad_load(p + 4));
}
SS_INLINE ss_pair ss_pair_load_any(const ss_real *p)
{
    ss_pair out;
    memcpy(&out, p, sizeof out);
    return out;
}
SS_INLINE void ss_pair_store(ss_real *p, ss_pair a)
{
    ss_quad_store(p, a.first);
    ss_quad_store(p + 4, a.second);
}
SS_INLINE ss_pair ss_pair_all(ss_real s)
{
    return ss_pair_of(ss_quad_all(s), ss_quad_all(s));
}
SS_INLINE ss_pair ss_pair_each(const ss_real *p)
{
    return ss_pair_of(ss_quad_all(p[0]), ss_quad_all(p[1]));
}
SS_INLINE int ss_pair_is_any_above(ss_pair a, ss_pair b)
{
    return ss_quad_is_any_above(a.first, b.first) | ss_quad_is_any_above(a.second, b.second);
}
SS_INLINE ss_pair ss_pair_lane(ss_pair a, int lane)
{
    return ss_pair_of(ss_quad_lane(a.first, lane), ss_quad_lane(a.second, lane));
}
SS_INLINE void ss_pair_transpose(ss_pair *a, ss_pair *b, ss_pair *c, ss_pair *d)
{
    ss_quad_transpose(&a->first, &b->first, &c->first, &d->first);
    ss_quad_transpose(&a->second, &b->second, &c->second, &d->second);
}

/* What quads do, on each of the two. */
#define SS_PAIR_OF_ONE(name)                                                                       \
    SS_INLINE ss_pair ss_pair_##name(ss_pair a)                                                    \
    {                                                                                              \
        return ss_pair_of(ss_quad_##name(a.first), ss_quad_##name(a.second));                      \
    }
#define SS_PAIR_OF_TWO(name)                                                                       \
    SS_INLINE ss_pair ss_pair_##name(ss_pair a, ss_pair b)                                         \
    {                                                                                              \
        return ss_pair_of(ss_quad_##name(a.first, b.first), ss_quad_##name(a.second, b.second));   \
    }
#define SS_PAIR_OF_THREE(name)                                                                     \
    SS_INLINE ss_pair ss_pair_##name(ss_pair a, ss_pair b, ss_pair c)                              \
    {                                                                                              \
        return ss_pair_of(ss_quad_##name(a.first, b.first, c.first),                               \
                          ss_quad_##name(a.second, b.second, c.second));                           \
    }
SS_PAIR_OF_ONE(root)
SS_PAIR_OF_ONE(xyz)
SS_PAIR_OF_TWO(add)
SS_PAIR_OF_TWO(sub)
SS_PAIR_OF_TWO(mul)
SS_PAIR_OF_TWO(div)
SS_PAIR_OF_TWO(most)
SS_PAIR_OF_TWO(least)
SS_PAIR_OF_THREE(fma)
SS_PAIR_OF_THREE(fnma)
#undef SS_PAIR_OF_ONE
#undef SS_PAIR_OF_TWO
#undef SS_PAIR_OF_THREE

#endif

/* Two nodes that lie apart, and one node twice. */
SS_INLINE ss_pair ss_pair_join(const ss_real *p, const ss_real *q)
{
    return ss_pair_of(ss_quad_load(p), ss_quad_load(q));
}
SS_INLINE ss_pair ss_pair_twice(ss_quad a)
{
    return ss_pair_of(a, a);
}
/* Each node's fourth lane in all four of it. */
SS_INLINE ss_pair ss_pair_last(ss_pair a)
{
    return ss_pair_lane(a, 3);
}
/* One node after the other, added up. */
SS_INLINE ss_quad ss_pair_both(ss_pair a)
{
    return ss_quad_add(ss_pair_first(a), ss_pair_second(a));
}
SS_INLINE double ss_pair_sum(ss_pair a)
{
    return ss_quad_sum(ss_pair_both(a));
}
SS_INLINE ss_quad ss_pair_fold(ss_pair a) /* the larger node's value of each lane */
{
    return ss_quad_most(ss_pair_first(a), ss_pair_second(a));
}

/* ---- wide ---- */

#if defined(SS_WIDE_AVX2) && !defined(SOFTSIM_DOUBLE)
#define SS_WIDE_LANES       8
#define SS_WIDE_OP(name)    _mm256_##name##_ps
#define SS_WIDE_BELOW(a, b) _mm256_cmp_ps(a, b, _CMP_LT_OQ)
#elif defined(SS_WIDE_AVX2)
#define SS_WIDE_LANES       4
#define SS_WIDE_OP(name)    _mm256_##name##_pd
#define SS_WIDE_BELOW(a, b) _mm256_cmp_pd(a, b, _CMP_LT_OQ)
#elif defined(SS_WIDE_SSE2) && !defined(SOFTSIM_DOUBLE)
#define SS_WIDE_LANES       4
#define SS_WIDE_OP(name)    _mm_##name##_ps
#define SS_WIDE_BELOW(a, b) _mm_cmplt_ps(a, b)
#elif defined(SS_WIDE_SSE2)
#define SS_WIDE_LANES       2
#define SS_WIDE_OP(name)    _mm_##name##_pd
#define SS_WIDE_BELOW(a, b) _mm_cmplt_pd(a, b)
#else
#define SS_WIDE_LANES 1
#endif
#ifdef SS_WIDE_OP
typedef ss_real ss_wide __attribute__((vector_size(SS_WIDE_LANES * sizeof(ss_real)), may_alias));
#else
typedef ss_real ss_wide;
#endif

SS_VECTOR_FUSED(ss_wide, SS_WIDE_OP)
SS_INLINE ss_wide ss_wide_all(ss_real s)
{
    return s - (ss_wide){0};
}
#ifdef SS_WIDE_OP
SS_VECTOR_OPS(ss_wide, SS_WIDE_OP)
#else
SS_VECTOR_TWO(ss_wide, most, a > b ? a : b)
SS_INLINE ss_wide ss_wide_root(ss_wide a)
{
    return (ss_wide)sqrt((double)a);
}
#endif
/* a where x < limit, else b. */
SS_INLINE ss_wide ss_wide_below(ss_wide x, ss_wide limit, ss_wide a, ss_wide b)
{
#ifdef SS_WIDE_AVX2
    return SS_WIDE_OP(blendv)(b, a, SS_WIDE_BELOW(x, limit));
#elif defined(SS_WIDE_OP)
    const ss_wide mask = SS_WIDE_BELOW(x, limit);
    return SS_WIDE_OP(or)(SS_WIDE_OP(and)(mask, a), SS_WIDE_OP(andnot)(mask, b));
#else
    return x < limit ? a : b;
#endif
}
/* Is x < limit in any lane? */
SS_INLINE bool ss_wide_any_below(ss_wide x, ss_wide limit)
{
#ifdef SS_WIDE_OP
    return SS_WIDE_OP(movemask)(SS_WIDE_BELOW(x, limit)) != 0;
#else
    return x < limit;
#endif
}

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
