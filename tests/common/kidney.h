/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* The kidney that worlds and servers under test hold: the bundled scene, on a mesh of 300 points
 * in place of its 1200, where what is claimed does not depend on the mesh. kidney-300.obj is
 * `softsim-mesh generate kidney --points 300`. */
#include <stdint.h>

#include "common/effort.h"

#define KIDNEY      SOURCE_DIR "/server/scenes/kidney.yaml"
#define KIDNEY_MESH SOURCE_DIR "/server/scenes/kidney.obj"
#define SMALL_MESH  SOURCE_DIR "/tests/common/kidney-300.obj"

/* As --set takes it. */
static inline const char *kidney_mesh(void)
{
    return FULL_IN_LONG_RUN("object.mesh=" KIDNEY_MESH, "object.mesh=" SMALL_MESH);
}

enum { KIDNEY_SETS = 8 };

/* It, and then `set`, into `out`; returns how many. */
static inline int32_t kidney_sets(const char *const *set, int32_t count,
                                  const char *out[KIDNEY_SETS])
{
    out[0] = kidney_mesh();
    for (int32_t k = 0; k < count && k + 1 < KIDNEY_SETS; ++k) {
        out[k + 1] = set[k];
    }
    return count + 1;
}
