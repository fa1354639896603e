/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Values of nodes as kernels have them, four a node. cmocka comes first. */
#include "common/number_fixture.h"
#include "rt/memory.h"
#include "rt/real.h"

static inline ss_real *quads(int32_t node_count)
{
    return ss_memory_get(((size_t)node_count + 7) / 8 * 8 * 4, sizeof(ss_real));
}

static inline ss_real *random_quads(int32_t node_count, double size)
{
    ss_real *q = quads(node_count);
    for (int32_t i = 0; i < node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            q[4 * (ptrdiff_t)i + k] = (ss_real)(size * random_unit());
        }
    }
    return q;
}
