/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "mesh/second_order.h"
/*
 * A mesh of first order gets nodes in the straight middle of its edges, one of second order loses
 * them. A new node is in a group where both ends of its edge are, and the edge lies on the surface
 * or a whole tetrahedron around it is in the group: what fem-quadratic does with sets of nodes.
 */
#include <string.h>

#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

const int8_t ss_mesh_edge_ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

const int8_t ss_mesh_edges_of_gmsh[6] = {0, 3, 1, 2, 5, 4};
const int8_t ss_mesh_edges_of_vtk[6] = {0, 3, 1, 2, 4, 5};
const int8_t ss_mesh_edges_of_tetgen[6] = {5, 2, 0, 3, 4, 1};

int ss_mesh_find_edge(const ss_mesh *mesh, int32_t e, int32_t a, int32_t b)
{
    const int32_t *corner = mesh->tetrahedron[e];
    int edge = 0;
    for (int s = 0; s < 6; ++s) {
        const int32_t first = corner[ss_mesh_edge_ends[s][0]];
        const int32_t last = corner[ss_mesh_edge_ends[s][1]];
        edge = (first == a && last == b) || (first == b && last == a) ? s : edge;
    }
    return edge;
}

/* ---- groups ---- */

/* The groups of `from` by the numbers that its nodes get (-1: it goes), and what `add` adds from
 * the marks of a group's nodes; those left empty go. */
typedef int32_t group_more(const void *owner, const uint8_t *is_in, int32_t *out_node);

static bool copy_groups(const ss_mesh *from, const int32_t *number, ss_mesh *to, group_more *more,
                        const void *owner)
{
    if (from->group_count == 0) {
        return true;
    }
    uint8_t *is_in = ss_memory_get((size_t)from->node_count, 1);
    int32_t *list = ss_memory_get((size_t)to->node_count, sizeof *list);
    to->group = ss_memory_get((size_t)from->group_count, sizeof *to->group);
    bool is_good = is_in != NULL && list != NULL && to->group != NULL;
    for (int32_t g = 0; is_good && g < from->group_count; ++g) {
        const ss_mesh_group *source = &from->group[g];
        int32_t count = 0;
        memset(is_in, 0, (size_t)from->node_count);
        for (int32_t i = 0; i < source->node_count; ++i) {
            is_in[source->node[i]] = 1;
            if (number[source->node[i]] >= 0) {
                list[count++] = number[source->node[i]];
            }
        }
        count += more != NULL ? more(owner, is_in, list + count) : 0;
        if (count == 0) {
            continue;
        }
        ss_mesh_group *group = &to->group[to->group_count];
        memcpy(group->name, source->name, sizeof group->name);
        group->node = ss_memory_get((size_t)count, sizeof *group->node);
        is_good = group->node != NULL;
        if (is_good) {
            memcpy(group->node, list, (size_t)count * sizeof *list);
            group->node_count = count;
            ++to->group_count;
        }
    }
    SS_EACH(ss_memory_free, is_in, list);
    return is_good;
}

static softsim_status fail(ss_mesh **mesh, softsim_error *error)
{
    ss_mesh_destroy(mesh);
    softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s",
                      "out of memory for a mesh of another order");
    return SOFTSIM_ERROR_MEMORY;
}

/* ---- up ---- */

typedef struct raiser {
    const ss_mesh *mesh;
    int32_t count; /* of edges */
    int32_t (*end)[2];
    bool *is_surface;
    int32_t (*ten)[10];
    double (*position)[3];
} raiser;

static void raiser_fini(raiser *r)
{
    SS_EACH(ss_memory_free, r->end, r->is_surface, r->ten, r->position);
}

/* Numbers the edges by their nodes, lower first. */
static bool raiser_init(raiser *r, const ss_mesh_tuples *edges)
{
    const ss_mesh *mesh = r->mesh;
    for (int64_t i = 0; i < edges->count; i = ss_mesh_run_end(edges, i)) {
        ++r->count;
    }
    r->end = ss_memory_get((size_t)r->count, sizeof *r->end);
    r->is_surface = ss_memory_get((size_t)r->count, sizeof *r->is_surface);
    r->ten = ss_memory_get((size_t)mesh->tetrahedron_count, sizeof *r->ten);
    r->position = ss_memory_get((size_t)mesh->node_count + (size_t)r->count, sizeof *r->position);
    if (!r->end || !r->is_surface || !r->ten || !r->position) {
        return false;
    }
    memcpy(r->position, mesh->position, (size_t)mesh->node_count * sizeof *r->position);
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        memcpy(r->ten[e], mesh->tetrahedron[e], sizeof *mesh->tetrahedron);
    }
    int32_t k = 0;
    for (int64_t i = 0; i < edges->count; ++k) {
        const int64_t last = ss_mesh_run_end(edges, i);
        double *x = r->position[mesh->node_count + k];
        memcpy(r->end[k], edges->tuple[i].node, sizeof *r->end);
        ss_add3(x, mesh->position[r->end[k][0]], mesh->position[r->end[k][1]]);
        ss_scale3(x, x, 0.5);
        for (; i < last; ++i) {
            r->ten[edges->tuple[i].id / 6][4 + edges->tuple[i].id % 6] = mesh->node_count + k;
        }
    }
    return true;
}

/* Both are sorted alike. */
static bool mark_surface(raiser *r)
{
    ss_mesh_tuples edges = {0};
    if (!ss_mesh_list_triangle_edges(r->mesh, &edges)) {
        return false;
    }
    int64_t i = 0;
    for (int32_t k = 0; k < r->count; ++k) {
        while (i < edges.count &&
               (edges.tuple[i].node[0] < r->end[k][0] || (edges.tuple[i].node[0] == r->end[k][0] &&
                                                          edges.tuple[i].node[1] < r->end[k][1]))) {
            ++i;
        }
        r->is_surface[k] =
            i < edges.count && memcmp(edges.tuple[i].node, r->end[k], sizeof *r->end) == 0;
    }
    ss_mesh_tuples_fini(&edges);
    return true;
}

static int32_t add_mid_edge_nodes(const void *owner, const uint8_t *is_in, int32_t *out_node)
{
    const raiser *r = owner;
    int32_t count = 0;
    bool *is_of_element = ss_memory_get((size_t)r->count, sizeof *is_of_element);
    for (int32_t e = 0; is_of_element != NULL && e < r->mesh->tetrahedron_count; ++e) {
        const int32_t *ten = r->ten[e];
        for (int s = 4; is_in[ten[0]] && is_in[ten[1]] && is_in[ten[2]] && is_in[ten[3]] && s < 10;
             ++s) {
            is_of_element[ten[s] - r->mesh->node_count] = true;
        }
    }
    for (int32_t k = 0; is_of_element != NULL && k < r->count; ++k) {
        if (is_of_element[k] || (r->is_surface[k] && is_in[r->end[k][0]] && is_in[r->end[k][1]])) {
            out_node[count++] = r->mesh->node_count + k;
        }
    }
    ss_memory_free(is_of_element);
    return count;
}

softsim_status ss_mesh_raise(const ss_mesh *mesh, ss_mesh **out_mesh, softsim_error *error)
{
    *out_mesh = NULL;
    raiser r = {.mesh = mesh};
    ss_mesh_tuples edges = {0};
    if (mesh->tetrahedron_count == 0 || mesh->middle != NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH, "%s",
                          mesh->middle != NULL
                              ? "it is of second order already: give one of first order"
                              : "a surface has no second order: give tetrahedra");
        return SOFTSIM_ERROR_MESH;
    }
    int32_t *number = ss_memory_get((size_t)mesh->node_count, sizeof *number);
    bool is_good = number != NULL && ss_mesh_list_tetrahedron_edges(mesh, &edges);
    if (is_good && edges.count != 6 * (int64_t)mesh->tetrahedron_count) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH, "%s",
                          "it has tetrahedra of nodes that do not exist, or with a node twice: "
                          "mend it first (softsim-mesh convert --repair)");
        ss_mesh_tuples_fini(&edges);
        ss_memory_free(number);
        return SOFTSIM_ERROR_MESH;
    }
    is_good = is_good && raiser_init(&r, &edges) && mark_surface(&r);
    ss_mesh_tuples_fini(&edges);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    for (int32_t i = 0; is_good && i < mesh->node_count; ++i) {
        number[i] = i;
    }
    if (is_good) {
        status = ss_mesh_create_second_order(
            mesh->node_count + r.count, (const double(*)[3])r.position, mesh->tetrahedron_count,
            (const int32_t(*)[10])r.ten, out_mesh, error);
    }
    if (!is_good ||
        (status == SOFTSIM_OK && !copy_groups(mesh, number, *out_mesh, add_mid_edge_nodes, &r))) {
        status = fail(out_mesh, error);
    }
    raiser_fini(&r);
    ss_memory_free(number);
    return status;
}

/* ---- down ---- */

softsim_status ss_mesh_lower(const ss_mesh *mesh, ss_mesh **out_mesh, softsim_error *error)
{
    enum { STAYS = 0, GOES = 1 };
    *out_mesh = NULL;
    const size_t nodes = (size_t)mesh->node_count, corners = 4 * (size_t)mesh->tetrahedron_count;
    int32_t *number = ss_memory_get(nodes, sizeof *number);
    int32_t(*tetrahedron)[4] = ss_memory_get(corners, sizeof(int32_t));
    double(*position)[3] = ss_memory_get(nodes, sizeof *position);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    int32_t count = 0;
    const bool is_good = number != NULL && tetrahedron != NULL && position != NULL;
    for (int64_t s = 0; is_good && mesh->middle != NULL && s < 6 * (int64_t)corners / 4; ++s) {
        const int32_t node = mesh->middle[s / 6][s % 6];
        number[node] = GOES;
    }
    for (size_t c = 0; is_good && c < corners; ++c) {
        number[mesh->tetrahedron[c / 4][c % 4]] = STAYS;
    }
    for (size_t i = 0; is_good && i < nodes; ++i) {
        const bool stays = number[i] == STAYS;
        if (stays) {
            ss_copy3(position[count], mesh->position[i]);
        }
        number[i] = stays ? count++ : -1;
    }
    for (size_t c = 0; is_good && c < corners; ++c) {
        tetrahedron[c / 4][c % 4] = number[mesh->tetrahedron[c / 4][c % 4]];
    }
    if (is_good) {
        status =
            ss_mesh_create(count, (const double(*)[3])position, 0, NULL, mesh->tetrahedron_count,
                           (const int32_t(*)[4])tetrahedron, out_mesh, error);
    }
    if (!is_good || (status == SOFTSIM_OK && !copy_groups(mesh, number, *out_mesh, NULL, NULL))) {
        status = fail(out_mesh, error);
    }
    SS_EACH(ss_memory_free, number, tetrahedron, position);
    return status;
}
