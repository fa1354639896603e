/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Results of the SIMD paths of one kernel, looked at path by path, best first. cmocka comes first.
 */
#include <string.h>

#include "common/quads_fixture.h"

/* Of AVX-512VL a kernel takes the registers alone: bit for bit what AVX2 gives. */
typedef struct path_results {
    const char *name;
    ss_real *value;
} path_results;

static inline void path_results_take(path_results *r, const char *name, int32_t node_count,
                                     const ss_real *value)
{
    const size_t bytes = 4 * (size_t)node_count * sizeof *value;
    if (r->name && strcmp(r->name, "avx512vl") == 0) {
        assert_string_equal(name, "avx2+fma");
        assert_memory_equal(value, r->value, bytes);
    }
    if (!r->value) {
        r->value = quads(node_count);
    }
    r->name = name;
    memcpy(r->value, value, bytes);
}

static inline void path_results_fini(path_results *r)
{
    ss_memory_free(r->value);
}
