/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Which path of a model's kernels runs: the best that was built and that this processor has.
 *
 * SS_KERNEL_PATHS(ss_x_kernels) in one source of the model defines ss_x_kernels_path and
 * ss_x_kernels_get of its header, from the tables ss_x_kernels_baseline and, where it was built,
 * ss_x_kernels_avx2; SS_KERNEL_PATHS_512 from ss_x_kernels_avx512vl besides, for a source that ends
 * with SS_KERNEL_TABLE_512. Macros, since the tables differ in type; rejected: one table of untyped
 * functions.
 */
#include <stddef.h>

#ifdef SS_HAS_AVX2
#define SS_KERNELS_AVX2(kernels)                                                                   \
    (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? &kernels##_avx2 : NULL)
/* Those that the third path is compiled for: CMakeLists.txt. */
#define SS_KERNELS_AVX512VL(kernels)                                                               \
    (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&                   \
             __builtin_cpu_supports("fma")                                                         \
         ? &kernels##_avx512vl                                                                     \
         : NULL)
#else
#define SS_KERNELS_AVX2(kernels)     NULL
#define SS_KERNELS_AVX512VL(kernels) NULL
#endif
#define SS_KERNEL_PATHS_OF(kernels, widest)                                                        \
    extern const kernels kernels##_baseline, kernels##_avx2, kernels##_avx512vl;                   \
    const kernels *kernels##_path(int32_t index)                                                   \
    {                                                                                              \
        const kernels *const built[] = {widest, SS_KERNELS_AVX2(kernels), &kernels##_baseline};    \
        for (size_t k = 0; k < sizeof built / sizeof *built; ++k) {                                \
            if (built[k] && index-- == 0) {                                                        \
                return built[k];                                                                   \
            }                                                                                      \
        }                                                                                          \
        return NULL;                                                                               \
    }                                                                                              \
    const kernels *kernels##_get(void)                                                             \
    {                                                                                              \
        return kernels##_path(0);                                                                  \
    }
#define SS_KERNEL_PATHS(kernels)     SS_KERNEL_PATHS_OF(kernels, NULL)
#define SS_KERNEL_PATHS_512(kernels) SS_KERNEL_PATHS_OF(kernels, SS_KERNELS_AVX512VL(kernels))
