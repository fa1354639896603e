/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_kernels.h"
/* Which path runs: the best that was built and that this processor has. */
#include <stddef.h>

extern const ss_fem_kernels ss_fem_kernels_baseline;
#ifdef SS_FEM_AVX2
extern const ss_fem_kernels ss_fem_kernels_avx2;
#endif

const ss_fem_kernels *ss_fem_kernels_path(int32_t index)
{
#ifdef SS_FEM_AVX2
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        return index == 0 ? &ss_fem_kernels_avx2 : index == 1 ? &ss_fem_kernels_baseline : NULL;
    }
#endif
    return index == 0 ? &ss_fem_kernels_baseline : NULL;
}

const ss_fem_kernels *ss_fem_kernels_get(void)
{
    return ss_fem_kernels_path(0);
}
