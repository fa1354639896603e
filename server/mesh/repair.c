/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Mending. Volumes and surfaces of quads, in this order: elements of nodes that do not exist or are
 * not finite go; nodes on top of others, and the ends of edges too short for any model, are welded;
 * elements that are then flat or duplicate go; inverted tetrahedra are turned; nodes without an
 * element go; surfaces are wound outwards (orient.c). Tolerances are those of ss_mesh_check. A
 * tetrahedron that is then on the same side of a face as its neighbour overlaps it: a node was
 * moved through others, which no order of nodes mends.
 *
 * Surfaces of triangles, and of quads that a scene would refuse after that: seams (stitch.c), then
 * sheets (sheets.c), slivers of parts and holes (holes.c), round and round until a round changes
 * nothing. So repairing what was repaired changes nothing either. Every step is a function of
 * the mesh alone.
 */
#include "mesh/mend.h"
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

enum { CORNERS = 4 }; /* of tetrahedra and quads */

typedef struct mender {
    const ss_mesh *mesh;  /* as given */
    ss_mesh work;         /* welded and turned: borrows positions and groups */
    int32_t *element;     /* of work: CORNERS nodes each */
    int32_t (*middle)[6]; /* of second order: theirs */
    int32_t *origin;      /* the element's number as given */
    int32_t count;
    int32_t *number; /* new number of a node, -1: goes */
    double (*position)[3];
    ss_mesh_repairs *done;
    double mean_edge;
} mender;

static bool is_finite_element(const ss_mesh *mesh, const int32_t *node, int corners)
{
    for (int k = 0; k < corners; ++k) {
        if (node[k] < 0 || node[k] >= mesh->node_count ||
            !ss_mesh_is_place(mesh->position[node[k]])) {
            return false;
        }
    }
    return true;
}

/* Twice the area of a quad's flatter half, cut along either diagonal where that is better. */
static double double_area(const ss_mesh *mesh, const int32_t *node)
{
    double area[4];
    for (int c = 0; c < 4; ++c) {
        double across[3];
        ss_normal3(across, mesh->position[node[c]], mesh->position[node[(c + 1) % 4]],
                   mesh->position[node[(c + 3) % 4]]);
        area[c] = ss_norm3(across);
    }
    return fmax(fmin(area[1], area[3]), fmin(area[0], area[2]));
}

static double volume_of(const ss_mesh *mesh, const int32_t *node)
{
    return ss_six_volumes3(mesh->position[node[0]], mesh->position[node[1]],
                           mesh->position[node[2]], mesh->position[node[3]]) /
           6.0;
}

/* Welds, drops and turns element e; true when it stays. */
static bool mend_element(mender *m, int32_t e)
{
    int32_t *node = m->element + (int64_t)CORNERS * e;
    int32_t *middle = m->middle != NULL ? m->middle[e] : NULL;
    const bool is_volume = m->mesh->tetrahedron_count > 0;
    const double h = m->mean_edge;
    if (!is_finite_element(m->mesh, node, CORNERS) ||
        (middle != NULL && !is_finite_element(m->mesh, middle, 6))) {
        ss_mesh_add_fault(&m->done->bad_element, e);
        return false;
    }
    for (int k = 0; k < CORNERS; ++k) {
        node[k] = m->number[node[k]];
    }
    for (int s = 0; middle != NULL && s < 6; ++s) {
        middle[s] = m->number[middle[s]];
    }
    const double volume = is_volume ? volume_of(m->mesh, node) : 0.0;
    const bool is_flat =
        !ss_mesh_has_good_nodes(m->mesh, node, CORNERS) ||
        (is_volume ? fabs(volume) <= SS_MESH_FLAT_VOLUME * h * h * h
                   : 0.5 * double_area(m->mesh, node) <= SS_MESH_FLAT_AREA * h * h);
    if (is_flat) {
        ss_mesh_add_fault(&m->done->flat_element, e);
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
        ss_mesh_add_fault(&m->done->turned_tetrahedron, e);
    }
    return true;
}

/* Element e becomes the next of those that are kept. */
static void keep(mender *m, int32_t e, int32_t *inout_kept)
{
    memmove(m->element + (int64_t)CORNERS * *inout_kept, m->element + (int64_t)CORNERS * e,
            (size_t)CORNERS * sizeof *m->element);
    if (m->middle != NULL) {
        memmove(m->middle[*inout_kept], m->middle[e], sizeof *m->middle);
    }
    m->origin[(*inout_kept)++] = m->origin[e];
}

static void mend_elements(mender *m)
{
    int32_t kept = 0;
    for (int32_t e = 0; e < m->count; ++e) {
        if (mend_element(m, e)) {
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
    } else {
        m->work.quad_count = m->count;
        m->work.quad = (void *)m->element;
    }
}

static bool drop_twins(mender *m)
{
    refer(m);
    ss_mesh_tuples tuples = {0};
    const bool is_listed = m->mesh->tetrahedron_count > 0
                               ? ss_mesh_list_tetrahedra(&m->work, &tuples)
                               : ss_mesh_list_quads(&m->work, &tuples);
    if (!is_listed) {
        return false;
    }
    for (int64_t i = 0; i < tuples.count;) {
        const int64_t end = ss_mesh_run_end(&tuples, i);
        for (int64_t k = i + 1; k < end; ++k) {
            m->element[(int64_t)CORNERS * tuples.tuple[k].id] = -1;
            ss_mesh_add_fault(&m->done->twin_element, m->origin[tuples.tuple[k].id]);
        }
        i = end;
    }
    ss_mesh_tuples_fini(&tuples);
    int32_t kept = 0;
    for (int32_t e = 0; e < m->count; ++e) {
        if (m->element[(int64_t)CORNERS * e] >= 0) {
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
    for (int64_t i = 0; i < (int64_t)CORNERS * m->count; ++i) {
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
            ss_mesh_add_fault(&m->done->welded_node, i);
        } else {
            ss_mesh_add_fault(&m->done->loose_node, i);
        }
    }
    for (int64_t i = 0; i < (int64_t)CORNERS * m->count; ++i) {
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
    return ss_mesh_create(nodes, x, 0, NULL, m->count, (const int32_t(*)[4])m->element, out, error);
}

/* The node that each is welded to, -1: none. Edges of second order have nodes in their middle. */
static bool find_welds(const ss_mesh *mesh, double mean_edge, int32_t *twin)
{
    const double reach = ss_mesh_twin_reach(mesh, mean_edge);
    int32_t *parent = ss_memory_get((size_t)mesh->node_count, sizeof *parent);
    const bool is_good = parent != NULL && ss_mesh_find_twins(mesh, reach, NULL, twin);
    if (is_good) {
        ss_mesh_union_init(parent, mesh->node_count);
    }
    for (int32_t i = 0; i < mesh->node_count && is_good; ++i) {
        ss_mesh_union_join(parent, i, twin[i] >= 0 ? twin[i] : i);
    }
    for (int32_t e = 0; e < mesh->tetrahedron_count && is_good && mesh->middle == NULL; ++e) {
        const int32_t *node = mesh->tetrahedron[e];
        for (int k = 0; k < 6 && is_finite_element(mesh, node, 4); ++k) {
            const int32_t a = node[k < 3   ? 0
                                   : k < 5 ? 1
                                           : 2],
                          b = node[k < 3   ? k + 1
                                   : k < 5 ? k - 1
                                           : 3];
            double d[3];
            ss_sub3(d, mesh->position[a], mesh->position[b]);
            if (ss_norm3(d) < SS_MEND_REACH * mean_edge) {
                ss_mesh_union_join(parent, a, b);
            }
        }
    }
    for (int32_t i = 0; i < mesh->node_count && is_good; ++i) {
        const int32_t to = ss_mesh_union_find(parent, i);
        twin[i] = to != i ? to : -1;
    }
    ss_memory_free(parent);
    return is_good;
}

/* Quads that run the other way round than they were given. */
static void count_turned(const mender *m, const ss_mesh *mesh)
{
    for (int32_t q = 0; q < mesh->quad_count; ++q) {
        const int32_t *now = mesh->quad[q], *before = m->element + CORNERS * (int64_t)q;
        int at = 0;
        while (at < 3 && now[at] != before[0]) {
            ++at;
        }
        if (now[(at + 1) % 4] != before[1]) {
            ss_mesh_add_fault(&m->done->turned_triangle, m->origin[q]);
        }
    }
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
        const int32_t turned = ss_mesh_orient(*out);
        if (turned < 0 || !copy_groups(m, *out)) {
            ss_mesh_destroy(out);
            return SOFTSIM_ERROR_MEMORY;
        }
        count_turned(m, *out);
    }
    return status;
}

static softsim_status mend_elements_of(const ss_mesh *mesh, ss_mesh **out, ss_mesh_repairs *done,
                                       softsim_error *error)
{
    ss_mesh_report report;
    const void *from =
        mesh->tetrahedron_count > 0 ? (const void *)mesh->tetrahedron : (const void *)mesh->quad;
    mender m = {.mesh = mesh, .count = ss_mesh_element_count(mesh), .done = done};
    const size_t nodes = (size_t)mesh->node_count, count = (size_t)m.count;
    int32_t *twin = ss_memory_get(nodes, sizeof *twin);
    m.number = ss_memory_get(nodes, sizeof *m.number);
    m.position = ss_memory_get(nodes, sizeof *m.position);
    m.element = ss_memory_get(count, CORNERS * sizeof *m.element);
    m.origin = ss_memory_get(count, sizeof *m.origin);
    m.middle = mesh->middle != NULL ? ss_memory_get(count, sizeof *m.middle) : NULL;
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if ((m.middle != NULL || mesh->middle == NULL) && twin != NULL && m.number != NULL &&
        m.position != NULL && m.element != NULL && m.origin != NULL &&
        ss_mesh_check(mesh, &report) == SOFTSIM_OK && find_welds(mesh, report.edge_mean, twin)) {
        m.mean_edge = report.edge_mean;
        memcpy(m.element, from, count * CORNERS * sizeof *m.element);
        for (int32_t e = 0; e < m.count; ++e) {
            m.origin[e] = e;
        }
        if (m.middle != NULL) {
            memcpy(m.middle, mesh->middle, count * sizeof *m.middle);
        }
        status = mend(&m, twin, out, error);
    }
    SS_EACH(ss_memory_free, twin, m.number, m.position, m.element, m.origin, m.middle);
    return status;
}

/* ---- elements that overlap ---- */

static softsim_status refuse_overlaps(const ss_mesh *mesh, softsim_error *error)
{
    ss_mesh_report report;
    if (ss_mesh_check(mesh, &report) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_MEMORY;
    }
    const ss_mesh_fault *overlap = &report.overlapping_tetrahedron;
    if (overlap->count == 0) {
        return SOFTSIM_OK;
    }
    const double *x = mesh->position[mesh->tetrahedron[overlap->first[0]][0]];
    softsim_error_add(
        error, SOFTSIM_ERROR_MESH,
        "%lld tetrahedra overlap their neighbours (the first is %d, at %.6g %.6g %.6g "
        "m), where nodes were moved through others: fill its surface again: "
        "softsim-mesh convert IN surface.obj; softsim-mesh convert --repair "
        "surface.obj mended.obj; softsim-mesh tetrahedralize mended.obj OUT.msh "
        "--edge-mm N",
        (long long)overlap->count, overlap->first[0], x[0], x[1], x[2]);
    return SOFTSIM_ERROR_MESH;
}

/* ---- all of it ---- */

softsim_status ss_mesh_repair(const ss_mesh *mesh, ss_mesh **out_mesh, ss_mesh_repairs *out_repairs,
                              softsim_error *error)
{
    *out_mesh = NULL;
    *out_repairs = (ss_mesh_repairs){0};
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (mesh->tetrahedron_count > 0 || mesh->quad_count > 0) {
        status = mend_elements_of(mesh, out_mesh, out_repairs, error);
    } else {
        status = ss_mend_surface(mesh, out_mesh, out_repairs, error);
    }
    if (status == SOFTSIM_OK && mesh->tetrahedron_count > 0) {
        status = refuse_overlaps(*out_mesh, error);
    }
    if (status == SOFTSIM_OK && mesh->quad_count > 0 &&
        ss_mesh_accept(*out_mesh, "", NULL) == SOFTSIM_ERROR_MESH) {
        ss_mesh_destroy(out_mesh);
        *out_repairs = (ss_mesh_repairs){0};
        for (int32_t q = 0; q < mesh->quad_count; ++q) {
            ss_mesh_add_fault(&out_repairs->cut_quad, q);
        }
        status = ss_mend_surface(mesh, out_mesh, out_repairs, error);
    }
    if (status != SOFTSIM_OK) {
        ss_mesh_destroy(out_mesh);
    }
    if (status == SOFTSIM_ERROR_MEMORY) {
        softsim_error_add(error, status, "out of memory while mending %d nodes", mesh->node_count);
    }
    return status;
}
