/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "mesh/leaves.h"

#include <math.h>
#include <stdlib.h>

#include "rt/order.h"
#include "rt/vec.h"

static int compare_leaves(const void *left, const void *right)
{
    const ss_leaf *a = left, *b = right;
    return ss_order_then(ss_order_double(a->angle, b->angle), ss_order_int(a->side, b->side));
}

void ss_mesh_sort_leaves(const ss_mesh *mesh, const ss_mesh_tuples *edges, int64_t begin,
                         int32_t count, ss_leaf_axis *out_axis, ss_leaf *out)
{
    const int32_t *node = edges->tuple[begin].node;
    ss_leaf_axis *axis = out_axis;
    ss_copy3(axis->from, mesh->position[node[0]]);
    ss_sub3(axis->along, mesh->position[node[1]], axis->from);
    axis->length = ss_normalize3(axis->along);
    for (int32_t i = 0; i < count; ++i) {
        const int32_t side = edges->tuple[begin + i].id;
        double to[3];
        ss_sub3(to, mesh->position[mesh->triangle[side / 3][(side % 3 + 2) % 3]], axis->from);
        ss_madd3(to, to, -ss_dot3(to, axis->along), axis->along);
        const double height = ss_normalize3(to);
        if (i == 0) {
            ss_copy3(axis->first, to);
            ss_cross3(axis->second, axis->along, axis->first);
        }
        const double angle = atan2(ss_dot3(to, axis->second), ss_dot3(to, axis->first));
        out[i] = (ss_leaf){.angle = angle < 0.0 ? angle + 2.0 * SS_PI : angle,
                           .height = height,
                           .side = side,
                           .is_ascending = ss_mesh_edge_is_ascending(mesh, side)};
    }
    qsort(out, (size_t)count, sizeof *out, compare_leaves);
}
