/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The surface that is mended: its arrays, and where its nodes and triangles come from.
 */
#include "mesh/mend.h"

#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

ss_mesh ss_mend_view(const ss_mend *m)
{
    return (ss_mesh){.node_count = m->node_count,
                     .position = m->position,
                     .triangle_count = m->triangle_count,
                     .triangle = m->triangle};
}

int32_t ss_mend_element(const ss_mend *m, int32_t triangle)
{
    const int32_t origin = m->origin[triangle];
    return origin < 0 ? origin : origin / m->part_count;
}

int32_t ss_mend_node(const ss_mend *m, int32_t node)
{
    return m->node_origin[node];
}

bool ss_mend_add_node(ss_mend *m, const double x[3], int32_t origin, int32_t *out_node)
{
    int32_t room = m->node_room;
    double(*position)[3] = ss_memory_grow(m->position, m->node_count, &room, sizeof *position);
    m->position = position != NULL ? position : m->position;
    room = m->node_room;
    int32_t *from = ss_memory_grow(m->node_origin, m->node_count, &room, sizeof *from);
    m->node_origin = from != NULL ? from : m->node_origin;
    if (position == NULL || from == NULL) {
        return false;
    }
    m->node_room = room;
    ss_copy3(m->position[m->node_count], x);
    m->node_origin[m->node_count] = origin;
    *out_node = m->node_count++;
    return true;
}

bool ss_mend_add_triangle(ss_mend *m, int32_t a, int32_t b, int32_t c, int32_t origin)
{
    int32_t room = m->triangle_room;
    int32_t(*triangle)[3] = ss_memory_grow(m->triangle, m->triangle_count, &room, sizeof *triangle);
    m->triangle = triangle != NULL ? triangle : m->triangle;
    room = m->triangle_room;
    int32_t *from = ss_memory_grow(m->origin, m->triangle_count, &room, sizeof *from);
    m->origin = from != NULL ? from : m->origin;
    if (triangle == NULL || from == NULL) {
        return false;
    }
    m->triangle_room = room;
    const int32_t node[3] = {a, b, c};
    memcpy(m->triangle[m->triangle_count], node, sizeof node);
    m->origin[m->triangle_count++] = origin;
    return true;
}

void ss_mend_drop_triangles(ss_mend *m)
{
    int32_t count = 0;
    for (int32_t t = 0; t < m->triangle_count; ++t) {
        if (m->triangle[t][0] >= 0) {
            memmove(m->triangle[count], m->triangle[t], sizeof m->triangle[t]);
            m->origin[count++] = m->origin[t];
        }
    }
    m->triangle_count = count;
}
