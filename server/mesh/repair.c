/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Mending what can be mended without a guess, in this order: elements of nodes that do not exist
 * or are not finite go; nodes on top of others are welded; elements that are then flat or there
 * already go; inverted tetrahedra are turned; nodes without an element go; surfaces are wound
 * outwards (orient.c). Tolerances are those of ss_mesh_check.
 *
 * Holes, crossings and edges of three triangles stay: what fills or parts them is for the owner of
 * the mesh to say. Of a quad whose corners are welded nothing is kept, for a surface of quads has
 * no triangles.
 */
#include "mesh/mesh.h"
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

typedef struct mender {
    const ss_mesh *mesh;  /* as given */
    ss_mesh work;         /* welded and turned: borrows positions and groups */
    int32_t *element;     /* of work: `corners` nodes each */
    int32_t (*middle)[6]; /* of second order: theirs */
    int32_t count, corners;
    int32_t *number; /* new number of a node, -1: goes */
    double (*position)[3];
    ss_mesh_repairs *done;
    double mean_edge;
} mender;

static bool is_finite_element(const ss_mesh *mesh, const int32_t *node, int corners)
{
    for (int k = 0; k < corners; ++k) {
        if (node[k] < 0 || node[k] >= mesh->node_count ||
            !ss_is_finite(mesh->position[node[k]], 3)) {
            return false;
        }
    }
    return true;
}

/* Twice the area of a triangle; of a quad that of its flatter half, cut along either diagonal where
 * that is better. */
static double double_area(const ss_mesh *mesh, const int32_t *node, int corners)
{
    double area[4];
    for (int c = 0; c < corners; ++c) {
        double across[3];
        const double *x = mesh->position[node[c]];
        ss_normal3(across, x, mesh->position[node[(c + 1) % corners]],
                   mesh->position[node[(c + corners - 1) % corners]]);
        area[c] = ss_norm3(across);
    }
    return corners == 3 ? area[0] : fmax(fmin(area[1], area[3]), fmin(area[0], area[2]));
}

static double volume_of(const ss_mesh *mesh, const int32_t *node)
{
    return ss_six_volumes3(mesh->position[node[0]], mesh->position[node[1]],
                           mesh->position[node[2]], mesh->position[node[3]]) /
           6.0;
}

/* Welds, drops and turns one element; true when it stays. `middle`: of second order, else NULL. */
static bool mend_element(mender *m, int32_t *node, int32_t *middle)
{
    const bool is_volume = m->mesh->tetrahedron_count > 0;
    const double h = m->mean_edge;
    if (!is_finite_element(m->mesh, node, m->corners) ||
        (middle != NULL && !is_finite_element(m->mesh, middle, 6))) {
        ++m->done->bad_elements;
        return false;
    }
    for (int k = 0; k < m->corners; ++k) {
        node[k] = m->number[node[k]];
    }
    for (int s = 0; middle != NULL && s < 6; ++s) {
        middle[s] = m->number[middle[s]];
    }
    const double volume = is_volume ? volume_of(m->mesh, node) : 0.0;
    const bool is_flat =
        !ss_mesh_has_good_nodes(m->mesh, node, m->corners) ||
        (is_volume ? fabs(volume) <= SS_MESH_FLAT_VOLUME * h * h * h
                   : 0.5 * double_area(m->mesh, node, m->corners) <= SS_MESH_FLAT_AREA * h * h);
    if (is_flat) {
        ++m->done->flat_elements;
        return false;
    }
    if (volume < 0.0) {
        const int32_t second = node[1];
        node[1] = node[2];
        node[2] = second;
        if (middle != NULL) {
            const int32_t turned[6] = {middle[1], middle[0], middle[2],
                                       middle[3], middle[5], middle[4]};
            memcpy(middle, turned, sizeof turned);
        }
        ++m->done->turned_tetrahedra;
    }
    return true;
}

/* Element e becomes the next of those that are kept. */
static void keep(mender *m, int32_t e, int32_t *inout_kept)
{
    memmove(m->element + (int64_t)m->corners * *inout_kept, m->element + (int64_t)m->corners * e,
            (size_t)m->corners * sizeof *m->element);
    if (m->middle != NULL) {
        memmove(m->middle[*inout_kept], m->middle[e], sizeof *m->middle);
    }
    ++*inout_kept;
}

static void mend_elements(mender *m)
{
    int32_t kept = 0;
    for (int32_t e = 0; e < m->count; ++e) {
        if (mend_element(m, m->element + (int64_t)m->corners * e,
                         m->middle != NULL ? m->middle[e] : NULL)) {
            keep(m, e, &kept);
        }
    }
    m->count = kept;
}

/* Points the work at the elements, so that topology.h can list them. */
static void refer(mender *m)
{
    m->work = (ss_mesh){.node_count = m->mesh->node_count, .position = m->mesh->position};
    if (m->mesh->tetrahedron_count > 0) {
        m->work.tetrahedron_count = m->count;
        m->work.tetrahedron = (void *)m->element;
    } else if (m->mesh->quad_count > 0) {
        m->work.quad_count = m->count;
        m->work.quad = (void *)m->element;
    } else {
        m->work.triangle_count = m->count;
        m->work.triangle = (void *)m->element;
    }
}

static bool drop_twins(mender *m)
{
    refer(m);
    ss_mesh_tuples tuples = {0};
    const bool is_listed = m->mesh->tetrahedron_count > 0
                               ? ss_mesh_list_tetrahedra(&m->work, &tuples)
                           : m->mesh->quad_count > 0 ? ss_mesh_list_quads(&m->work, &tuples)
                                                     : ss_mesh_list_triangles(&m->work, &tuples);
    if (!is_listed) {
        return false;
    }
    for (int64_t i = 0; i < tuples.count;) {
        const int64_t end = ss_mesh_run_end(&tuples, i);
        for (int64_t k = i + 1; k < end; ++k) {
            m->element[(int64_t)m->corners * tuples.tuple[k].id] = -1;
            ++m->done->twin_elements;
        }
        i = end;
    }
    ss_mesh_tuples_fini(&tuples);
    int32_t kept = 0;
    for (int32_t e = 0; e < m->count; ++e) {
        if (m->element[(int64_t)m->corners * e] >= 0) {
            keep(m, e, &kept);
        }
    }
    m->count = kept;
    return true;
}

/* Numbers the nodes in use; `twin` holds for each node the one it was welded to, or -1. */
static int32_t number_nodes(mender *m, const int32_t *twin)
{
    const int32_t nodes = m->mesh->node_count;
    memset(m->number, 0xff, (size_t)nodes * sizeof *m->number);
    int32_t *middle = (int32_t *)m->middle;
    const int64_t middles = middle != NULL ? 6 * (int64_t)m->count : 0;
    for (int64_t i = 0; i < (int64_t)m->corners * m->count; ++i) {
        m->number[m->element[i]] = 0;
    }
    for (int64_t i = 0; i < middles; ++i) {
        m->number[middle[i]] = 0;
    }
    int32_t count = 0;
    for (int32_t i = 0; i < nodes; ++i) {
        if (m->number[i] == 0) {
            ss_copy3(m->position[count], m->mesh->position[i]);
            m->number[i] = count++;
        } else if (twin[i] >= 0) {
            m->number[i] = m->number[twin[i]]; /* lower, so settled */
            ++m->done->welded_nodes;
        } else {
            ++m->done->loose_nodes;
        }
    }
    for (int64_t i = 0; i < (int64_t)m->corners * m->count; ++i) {
        m->element[i] = m->number[m->element[i]];
    }
    for (int64_t i = 0; i < middles; ++i) {
        middle[i] = m->number[middle[i]];
    }
    return count;
}

/* Groups with the new numbers, each node once. */
static bool copy_groups(const mender *m, ss_mesh *to)
{
    int32_t *seen_in = ss_memory_get((size_t)to->node_count, sizeof *seen_in); /* group + 1 */
    to->group = ss_memory_get((size_t)m->mesh->group_count, sizeof *to->group);
    bool is_good = seen_in != NULL && to->group != NULL;
    for (int32_t g = 0; g < m->mesh->group_count && is_good; ++g) {
        const ss_mesh_group *from = &m->mesh->group[g];
        ss_mesh_group *group = &to->group[to->group_count++];
        memcpy(group->name, from->name, sizeof group->name);
        group->node = ss_memory_get((size_t)from->node_count, sizeof *group->node);
        is_good = group->node != NULL;
        for (int32_t i = 0; i < from->node_count && is_good; ++i) {
            const int32_t node = m->number[from->node[i]];
            if (node >= 0 && seen_in[node] != g + 1) {
                seen_in[node] = g + 1;
                group->node[group->node_count++] = node;
            }
        }
    }
    ss_memory_free(seen_in);
    return is_good;
}

static softsim_status create_second_order(mender *m, int32_t nodes, ss_mesh **out,
                                          softsim_error *error)
{
    int32_t(*ten)[10] = ss_memory_get((size_t)m->count, sizeof *ten);
    for (int32_t e = 0; ten != NULL && e < m->count; ++e) {
        memcpy(ten[e], m->element + 4 * (int64_t)e, 4 * sizeof **ten);
        memcpy(ten[e] + 4, m->middle[e], sizeof *m->middle);
    }
    const softsim_status status =
        ten != NULL ? ss_mesh_create_second_order(nodes, (const double(*)[3])m->position, m->count,
                                                  (const int32_t(*)[10])ten, out, error)
                    : SOFTSIM_ERROR_MEMORY;
    ss_memory_free(ten);
    return status;
}

static softsim_status create(mender *m, int32_t nodes, ss_mesh **out, softsim_error *error)
{
    const double(*x)[3] = (const double(*)[3])m->position;
    if (m->mesh->quad_count > 0 && m->count > 0) {
        return ss_mesh_create_quads(nodes, x, m->count, (const int32_t(*)[4])m->element, out,
                                    error);
    }
    if (m->middle != NULL && m->count > 0) {
        return create_second_order(m, nodes, out, error);
    }
    const bool is_volume = m->mesh->tetrahedron_count > 0;
    return ss_mesh_create(nodes, x, is_volume ? 0 : m->count, (const int32_t(*)[3])m->element,
                          is_volume ? m->count : 0, (const int32_t(*)[4])m->element, out, error);
}

static softsim_status mend(mender *m, const int32_t *twin, ss_mesh **out, softsim_error *error)
{
    for (int32_t i = 0; i < m->mesh->node_count; ++i) {
        m->number[i] = twin[i] >= 0 ? twin[i] : i;
    }
    mend_elements(m);
    if (!drop_twins(m)) {
        return SOFTSIM_ERROR_MEMORY;
    }
    const int32_t nodes = number_nodes(m, twin);
    const softsim_status status = create(m, nodes, out, error);
    if (status == SOFTSIM_OK) {
        m->done->turned_triangles = ss_mesh_orient(*out);
        if (m->done->turned_triangles < 0 || !copy_groups(m, *out)) {
            ss_mesh_destroy(out);
            return SOFTSIM_ERROR_MEMORY;
        }
    }
    return status;
}

softsim_status ss_mesh_repair(const ss_mesh *mesh, ss_mesh **out_mesh, ss_mesh_repairs *out_repairs,
                              softsim_error *error)
{
    *out_mesh = NULL;
    *out_repairs = (ss_mesh_repairs){0};
    ss_mesh_report report;
    const bool is_volume = mesh->tetrahedron_count > 0;
    const void *from = is_volume              ? (const void *)mesh->tetrahedron
                       : mesh->quad_count > 0 ? (const void *)mesh->quad
                                              : (const void *)mesh->triangle;
    mender m = {.mesh = mesh,
                .count = ss_mesh_element_count(mesh),
                .corners = is_volume || mesh->quad_count > 0 ? 4 : 3,
                .done = out_repairs};
    const size_t nodes = (size_t)mesh->node_count;
    const size_t size = (size_t)m.count * (size_t)m.corners;
    int32_t *twin = ss_memory_get(nodes, sizeof *twin);
    m.number = ss_memory_get(nodes, sizeof *m.number);
    m.position = ss_memory_get(nodes, sizeof *m.position);
    m.element = ss_memory_get(size, sizeof *m.element);
    m.middle = mesh->middle != NULL ? ss_memory_get((size_t)m.count, sizeof *m.middle) : NULL;
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if ((m.middle != NULL || mesh->middle == NULL) && twin != NULL && m.number != NULL &&
        m.position != NULL && m.element != NULL && ss_mesh_check(mesh, &report) == SOFTSIM_OK &&
        ss_mesh_find_twins(mesh, &report, twin)) {
        m.mean_edge = report.edge_mean;
        memcpy(m.element, from, size * sizeof *m.element);
        if (m.middle != NULL) {
            memcpy(m.middle, mesh->middle, (size_t)m.count * sizeof *m.middle);
        }
        status = mend(&m, twin, out_mesh, error);
    }
    if (status == SOFTSIM_ERROR_MEMORY) {
        softsim_error_add(error, status, "out of memory while mending %d nodes", mesh->node_count);
    }
    SS_EACH(ss_memory_free, twin, m.number, m.position, m.element, m.middle);
    return status;
}
