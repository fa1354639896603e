/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Which path of a model's kernels runs: the best that was built and that this processor has.
 *
 * SS_KERNEL_PATHS(ss_x_kernels) in one source of the model defines ss_x_kernels_path and
 * ss_x_kernels_get of its header, from the tables ss_x_kernels_baseline and, where it was built,
 * ss_x_kernels_avx2. A macro, since the tables differ in type; rejected: one table of untyped
 * functions.
 */
#include <stddef.h>

#ifdef SS_HAS_AVX2
#define SS_KERNELS_WIDE(kernels)                                                                   \
    (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? &kernels##_avx2 : NULL)
#else
#define SS_KERNELS_WIDE(kernels) NULL
#endif
#define SS_KERNEL_PATHS(kernels)                                                                   \
    extern const kernels kernels##_baseline, kernels##_avx2;                                       \
    const kernels *kernels##_path(int32_t index)                                                   \
    {                                                                                              \
        const kernels *const wide = SS_KERNELS_WIDE(kernels);                                      \
        return index == 0 && wide ? wide : index == (wide ? 1 : 0) ? &kernels##_baseline : NULL;   \
    }                                                                                              \
    const kernels *kernels##_get(void)                                                             \
    {                                                                                              \
        return kernels##_path(0);                                                                  \
    }
