/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Mending a surface: the rounds of stitch.c, sheets.c and holes.c, and the mesh that comes out. The
 * rounds end when one has changed nothing. They could only go on for ever by parting what they
 * join, which the lengths in mend.h exclude; a bound keeps them finite.
 */
#include "mesh/mend.h"

#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

enum { MAX_ROUNDS = 24 };

/* ---- rounds ---- */

static bool begin(ss_mend *m, const ss_mesh *mesh, ss_mesh_repairs *done)
{
    const size_t nodes = (size_t)mesh->node_count, triangles = (size_t)mesh->triangle_count;
    *m = (ss_mend){.node_room = mesh->node_count,
                   .triangle_room = mesh->triangle_count,
                   .part_count = mesh->quad_count > 0 ? 2 : 1,
                   .done = done};
    m->position = ss_memory_get(nodes, sizeof *m->position);
    m->node_origin = ss_memory_get(nodes, sizeof *m->node_origin);
    m->triangle = ss_memory_get(triangles, sizeof *m->triangle);
    m->origin = ss_memory_get(triangles, sizeof *m->origin);
    m->root = ss_memory_get(nodes, sizeof *m->root);
    if (m->position == NULL || m->node_origin == NULL || m->triangle == NULL || m->origin == NULL ||
        m->root == NULL) {
        return false;
    }
    ss_mesh_union_init(m->root, mesh->node_count);
    m->node_count = mesh->node_count;
    memcpy(m->position, mesh->position, nodes * sizeof *m->position);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        m->node_origin[i] = i;
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        bool is_good = true;
        for (int k = 0; k < 3; ++k) {
            const int32_t node = mesh->triangle[t][k];
            is_good = is_good && node >= 0 && node < mesh->node_count &&
                      ss_mesh_is_place(mesh->position[node]);
        }
        if (is_good) {
            memcpy(m->triangle[m->triangle_count], mesh->triangle[t], sizeof m->triangle[0]);
            m->origin[m->triangle_count++] = t;
        } else {
            ss_mesh_add_fault(&done->bad_element, t / m->part_count);
        }
    }
    return true;
}

static bool measure_mean_edge(ss_mend *m)
{
    const ss_mesh view = ss_mend_view(m);
    ss_mesh_tuples edges = {0};
    if (!ss_mesh_list_triangle_edges(&view, &edges)) {
        return false;
    }
    int64_t count = 0;
    double sum = 0.0;
    for (int64_t i = 0; i < edges.count; i = ss_mesh_run_end(&edges, i)) {
        double d[3];
        ss_sub3(d, m->position[edges.tuple[i].node[1]], m->position[edges.tuple[i].node[0]]);
        sum += ss_norm3(d);
        ++count;
    }
    m->mean_edge = count > 0 ? sum / (double)count : 0.0;
    ss_mesh_tuples_fini(&edges);
    return true;
}

static int64_t sum_repairs(const ss_mesh_repairs *done)
{
    ss_mesh_finding found[SS_MESH_MAX_FINDINGS];
    const int32_t count = ss_mesh_list_repairs(done, false, found);
    int64_t sum = 0;
    for (int32_t i = 0; i < count; ++i) {
        sum += found[i].fault->count;
    }
    return sum;
}

static bool go_round(ss_mend *m)
{
    int64_t before = -1;
    for (int round = 0; round < MAX_ROUNDS && before != sum_repairs(m->done); ++round) {
        before = sum_repairs(m->done);
        if (!measure_mean_edge(m) || !ss_mend_stitch(m) || !ss_mend_part_sheets(m) ||
            !ss_mend_drop_small_parts(m) || !ss_mend_fill_holes(m)) {
            return false;
        }
    }
    return true;
}

/* ---- the mesh that comes out ---- */

/* Packs the nodes in use, in order; `number`: the new one of each, -1: goes. */
static bool number_nodes(ss_mend *m, int32_t file_nodes)
{
    int32_t *number = ss_memory_get((size_t)m->node_count, sizeof *number);
    bool *is_kept = ss_memory_get((size_t)file_nodes, sizeof *is_kept); /* of roots */
    if (number == NULL || is_kept == NULL) {
        SS_EACH(ss_memory_free, number, is_kept);
        return false;
    }
    for (int32_t c = 0; c < 3 * m->triangle_count; ++c) {
        number[m->triangle[c / 3][c % 3]] = 1;
    }
    int32_t count = 0;
    for (int32_t i = 0; i < m->node_count; ++i) {
        if (number[i] == 0) {
            continue;
        }
        const int32_t origin = m->node_origin[i];
        if (origin >= 0) {
            is_kept[ss_mesh_union_find(m->root, origin)] = true;
        }
        ss_copy3(m->position[count], m->position[i]);
        m->node_origin[count] = origin;
        number[i] = count++;
    }
    for (int32_t i = 0; i < file_nodes; ++i) {
        if (!is_kept[ss_mesh_union_find(m->root, i)]) {
            ss_mesh_add_fault(&m->done->loose_node, i);
        }
    }
    for (int32_t c = 0; c < 3 * m->triangle_count; ++c) {
        m->triangle[c / 3][c % 3] = number[m->triangle[c / 3][c % 3]];
    }
    m->node_count = count;
    SS_EACH(ss_memory_free, number, is_kept);
    return true;
}

/* A node is in a group when one that it stems from, or that was welded to that, is. */
static bool copy_groups(ss_mend *m, const ss_mesh *from, ss_mesh *to)
{
    int32_t *mark = ss_memory_get((size_t)from->node_count, sizeof *mark);
    to->group = ss_memory_get((size_t)from->group_count, sizeof *to->group);
    bool is_good = mark != NULL && to->group != NULL;
    for (int32_t g = 0; g < from->group_count && is_good; ++g) {
        const ss_mesh_group *source = &from->group[g];
        ss_mesh_group *group = &to->group[to->group_count++];
        memcpy(group->name, source->name, sizeof group->name);
        group->node = ss_memory_get((size_t)to->node_count, sizeof *group->node);
        is_good = group->node != NULL;
        for (int32_t i = 0; i < source->node_count && is_good; ++i) {
            mark[ss_mesh_union_find(m->root, source->node[i])] = g + 1;
        }
        for (int32_t i = 0; i < to->node_count && is_good; ++i) {
            const int32_t origin = m->node_origin[i];
            if (origin >= 0 && mark[ss_mesh_union_find(m->root, origin)] == g + 1) {
                group->node[group->node_count++] = i;
            }
        }
    }
    ss_memory_free(mark);
    return is_good;
}

/* Triangles that have the nodes they had, the other way round. */
static void count_turned(const ss_mend *m, const ss_mesh *from, const ss_mesh *to)
{
    for (int32_t t = 0; t < to->triangle_count; ++t) {
        const int32_t origin = m->origin[t];
        int at[3] = {-1, -1, -1};
        for (int k = 0; k < 3 && origin >= 0; ++k) {
            const int32_t node = m->node_origin[to->triangle[t][k]];
            for (int i = 0; i < 3 && node >= 0; ++i) {
                at[k] = ss_mesh_union_find(m->root, from->triangle[origin][i]) ==
                                ss_mesh_union_find(m->root, node)
                            ? i
                            : at[k];
            }
        }
        if (at[0] >= 0 && at[1] == (at[0] + 2) % 3 && at[2] == (at[0] + 1) % 3) {
            ss_mesh_add_fault(&m->done->turned_triangle, ss_mend_element(m, t));
        }
    }
}

softsim_status ss_mend_surface(const ss_mesh *mesh, ss_mesh **out_mesh, ss_mesh_repairs *done,
                               softsim_error *error)
{
    ss_mend m;
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (begin(&m, mesh, done) && go_round(&m) && number_nodes(&m, mesh->node_count)) {
        status = ss_mesh_create(m.node_count, (const double(*)[3])m.position, m.triangle_count,
                                (const int32_t(*)[3])m.triangle, 0, NULL, out_mesh, error);
    }
    if (status == SOFTSIM_OK) {
        if (ss_mesh_orient(*out_mesh) >= 0 && copy_groups(&m, mesh, *out_mesh)) {
            count_turned(&m, mesh, *out_mesh);
        } else {
            ss_mesh_destroy(out_mesh);
            status = SOFTSIM_ERROR_MEMORY;
        }
    }
    SS_EACH(ss_memory_free, m.position, m.node_origin, m.triangle, m.origin, m.root);
    return status;
}
