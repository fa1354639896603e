/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What is wrong with a mesh. One pass over nodes, elements, edges and faces each; shared edges
 * and faces by sorted tuples (topology.h), coincident nodes by a grid of cells.
 *
 * A node is non-manifold when the triangles around it form more than one fan: corners of
 * neighbouring triangles are joined across their common edges, and each node may have one set of
 * corners. The surface of a volume may touch itself in nodes and edges (pinch.c): no fault.
 * Measures are relative to the mean edge h, so that a body in millimetres is judged as the same
 * body in metres.
 */
#include "mesh/mesh.h"
#include "mesh/tetrahedron.h"
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

/* Relative to h; areas and volumes: topology.h. */
static const double coincidence = 1e-6;
static const double short_edge = 1e-3;

/* ---- nodes ---- */

static void check_positions(const ss_mesh *mesh, ss_mesh_report *report)
{
    bool is_first = true;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        const double *x = mesh->position[i];
        if (!ss_mesh_is_place(x)) {
            ss_mesh_add_fault(&report->non_finite, i);
            continue;
        }
        for (int k = 0; k < 3; ++k) {
            report->box_min[k] = is_first ? x[k] : fmin(report->box_min[k], x[k]);
            report->box_max[k] = is_first ? x[k] : fmax(report->box_max[k], x[k]);
        }
        is_first = false;
    }
}

static uint64_t hash_cell(const double cell[3])
{
    uint64_t hash = SS_HASH_START;
    for (int k = 0; k < 3; ++k) {
        uint64_t bits;
        const double value = cell[k] + 0.0; /* -0 and 0 are one cell */
        memcpy(&bits, &value, sizeof bits);
        hash = ss_hash_word(hash, bits);
    }
    return hash;
}

/* A node within `reach` of x among those in the cell at `cell` (in units of cells), or -1. */
static int32_t find_in_cell(const ss_mesh *mesh, const int32_t *head, const int32_t *next,
                            uint64_t mask, const double cell[3], const double x[3], double reach)
{
    for (int32_t i = head[hash_cell(cell) & mask]; i >= 0; i = next[i]) {
        double d[3];
        ss_sub3(d, x, mesh->position[i]);
        if (ss_norm3(d) <= reach) {
            return i;
        }
    }
    return -1;
}

/* Looks into the up to eight cells that the cube of half width `reach` about x overlaps. */
static int32_t find_twin(const ss_mesh *mesh, const int32_t *head, const int32_t *next,
                         uint64_t mask, const double x[3], double reach, double size)
{
    int32_t twin = -1;
    for (int corner = 0; corner < 8; ++corner) {
        double cell[3];
        bool is_new = true;
        for (int k = 0; k < 3; ++k) {
            const bool is_high = (corner >> k & 1) != 0;
            cell[k] = floor((x[k] + (is_high ? reach : -reach)) / size);
            is_new = is_new && !(is_high && cell[k] == floor((x[k] - reach) / size));
        }
        const int32_t found = is_new ? find_in_cell(mesh, head, next, mask, cell, x, reach) : -1;
        twin = found >= 0 && (twin < 0 || found < twin) ? found : twin;
    }
    return twin;
}

double ss_mesh_twin_reach(const ss_mesh *mesh, double mean_edge)
{
    double largest = 0.0;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int k = 0; k < 3 && ss_is_finite(mesh->position[i], 3); ++k) {
            largest = fmax(largest, fabs(mesh->position[i][k]));
        }
    }
    return fmax(fmax(coincidence * mean_edge, 1e-15 * largest), 1e-300);
}

/* A twin is not entered into the grid, so that cells stay sparse on any input: entered nodes are
 * more than `reach` apart, a cell is 16 reaches wide. */
bool ss_mesh_find_twins(const ss_mesh *mesh, double reach, const bool *is_used, int32_t *out_twin)
{
    uint64_t mask = 1;
    while (mask < 2 * (uint64_t)mesh->node_count) {
        mask *= 2;
    }
    int32_t *head = ss_memory_get(mask, sizeof *head);
    int32_t *next = ss_memory_get((size_t)mesh->node_count, sizeof *next);
    if (head == NULL || next == NULL) {
        ss_memory_free(head);
        ss_memory_free(next);
        return false;
    }
    memset(head, 0xff, mask * sizeof *head);
    --mask;

    const double size = 16.0 * reach;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        const double *x = mesh->position[i];
        out_twin[i] = -1;
        if (!ss_is_finite(x, 3) || (is_used != NULL && !is_used[i])) {
            continue;
        }
        out_twin[i] = find_twin(mesh, head, next, mask, x, reach, size);
        if (out_twin[i] >= 0) {
            continue;
        }
        const double cell[3] = {floor(x[0] / size), floor(x[1] / size), floor(x[2] / size)};
        int32_t *bucket = &head[hash_cell(cell) & mask];
        next[i] = *bucket;
        *bucket = i;
    }
    ss_memory_free(head);
    ss_memory_free(next);
    return true;
}

static bool find_coincident(const ss_mesh *mesh, ss_mesh_report *report)
{
    int32_t *twin = ss_memory_get((size_t)mesh->node_count, sizeof *twin);
    const double reach = ss_mesh_twin_reach(mesh, report->edge_mean);
    const bool is_done = twin != NULL && ss_mesh_find_twins(mesh, reach, NULL, twin);
    for (int32_t i = 0; i < mesh->node_count && is_done; ++i) {
        if (twin[i] >= 0) {
            ss_mesh_add_fault(&report->coincident_node, i);
        }
    }
    ss_memory_free(twin);
    return is_done;
}

/* ---- edges ---- */

static double edge_length(const ss_mesh *mesh, const ss_mesh_tuple *edge)
{
    double d[3];
    ss_sub3(d, mesh->position[edge->node[1]], mesh->position[edge->node[0]]);
    return ss_norm3(d);
}

static void measure_edges(const ss_mesh *mesh, const ss_mesh_tuples *edges, ss_mesh_report *report)
{
    int64_t count = 0;
    double sum = 0.0;
    for (int64_t i = 0; i < edges->count; i = ss_mesh_run_end(edges, i)) {
        const double length = edge_length(mesh, &edges->tuple[i]);
        if (isfinite(length)) {
            report->edge_min = count == 0 ? length : fmin(report->edge_min, length);
            report->edge_max = fmax(report->edge_max, length);
            sum += length;
            ++count;
        }
    }
    report->edge_mean = count > 0 ? sum / (double)count : 0.0;
    for (int64_t i = 0; i < edges->count; i = ss_mesh_run_end(edges, i)) {
        if (edge_length(mesh, &edges->tuple[i]) < short_edge * report->edge_mean) {
            ss_mesh_add_fault(&report->short_edge, edges->tuple[i].node[0]);
        }
    }
}

/* Corners of edge `id` (3 t + c) in triangle t: the one at its lower node, the one at its higher.
 */
static void edge_corners(const ss_mesh *mesh, int32_t id, int32_t out[2])
{
    const int32_t start = id;
    const int32_t end = id / 3 * 3 + (id % 3 + 1) % 3;
    const bool is_ascending = ss_mesh_edge_is_ascending(mesh, id);
    out[0] = is_ascending ? start : end;
    out[1] = is_ascending ? end : start;
}

static void join_corners(const ss_mesh *mesh, int32_t side, int32_t other, int32_t *corner_set)
{
    int32_t first[2], second[2];
    edge_corners(mesh, side, first);
    edge_corners(mesh, other, second);
    ss_mesh_union_join(corner_set, first[0], second[0]);
    ss_mesh_union_join(corner_set, first[1], second[1]);
}

/* `twin`: of ss_mesh_pair_sides. Where triangles cannot be paired they all are one corner. */
static void check_edges(const ss_mesh *mesh, const ss_mesh_tuples *edges, const int32_t *twin,
                        int32_t *corner_set, ss_mesh_report *report)
{
    const bool is_volume = mesh->tetrahedron_count > 0;
    ss_mesh_union_init(corner_set, 3 * mesh->triangle_count);
    for (int64_t i = 0; i < edges->count;) {
        const int64_t end = ss_mesh_run_end(edges, i);
        const ss_mesh_tuple *edge = &edges->tuple[i];
        if (end - i == 1) {
            ss_mesh_add_fault(&report->open_edge, edge->node[0]);
        } else if (end - i > 2) {
            const bool is_pinched = is_volume && twin[edge->id] >= 0;
            ss_mesh_add_fault(is_pinched ? &report->pinched_edge : &report->non_manifold_edge,
                              edge->node[0]);
        } else if (ss_mesh_edge_is_ascending(mesh, edge[0].id) ==
                   ss_mesh_edge_is_ascending(mesh, edge[1].id)) {
            ss_mesh_add_fault(&report->inconsistent_winding, edge->node[0]);
        }
        for (int64_t k = i; k < end; ++k) {
            const int32_t side = edges->tuple[k].id;
            const bool is_paired = is_volume && twin[side] >= 0;
            join_corners(mesh, side, is_paired ? twin[side] : edge->id, corner_set);
        }
        i = end;
    }
}

/* Counts fans: `fans` is zeroed scratch of node_count. */
static void check_fans(const ss_mesh *mesh, int32_t *corner_set, int32_t *fans,
                       ss_mesh_report *report)
{
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        if (!ss_mesh_has_good_nodes(mesh, mesh->triangle[t], 3)) {
            continue;
        }
        for (int32_t c = 0; c < 3; ++c) {
            if (ss_mesh_union_find(corner_set, 3 * t + c) == 3 * t + c) {
                ++fans[mesh->triangle[t][c]];
            }
        }
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (fans[i] > 1) {
            ss_mesh_add_fault(mesh->tetrahedron_count > 0 ? &report->pinched_node
                                                          : &report->non_manifold_node,
                              i);
        }
    }
}

/* ---- triangles ---- */

static bool indices_are_good(const ss_mesh *mesh, const int32_t *node, int count)
{
    for (int k = 0; k < count; ++k) {
        if (node[k] < 0 || node[k] >= mesh->node_count) {
            return false;
        }
    }
    return true;
}

/* Area of a triangle; *inout_angle is lowered to the angle at its first node in degrees, by
 * tan a = |u x v| / u . v. */
static double measure_corner(const ss_mesh *mesh, const int32_t *node, double *inout_angle)
{
    double u[3], v[3], uv[3];
    ss_sub3(u, mesh->position[node[1]], mesh->position[node[0]]);
    ss_sub3(v, mesh->position[node[2]], mesh->position[node[0]]);
    ss_cross3(uv, u, v);
    const double area = 0.5 * ss_norm3(uv);
    *inout_angle = fmin(*inout_angle, atan2(2.0 * area, ss_dot3(u, v)) * (180.0 / SS_PI));
    return area;
}

/* Area; *out_is_flat where it is below `least`. */
static double check_triangle(const ss_mesh *mesh, int32_t t, double least, double *inout_angle,
                             bool *out_is_flat)
{
    const int32_t *node = mesh->triangle[t];
    double area = 0.0;
    for (int c = 0; c < 3; ++c) {
        const int32_t corner[3] = {node[c], node[(c + 1) % 3], node[(c + 2) % 3]};
        area = measure_corner(mesh, corner, inout_angle);
    }
    *out_is_flat = area <= least;
    return area;
}

/* Area as ss_mesh_node_areas sums it; flat where a half is, or with a corner twice. */
static double check_quad(const ss_mesh *mesh, int32_t q, double least, double *inout_angle,
                         bool *out_is_flat)
{
    const int32_t *node = mesh->quad[q];
    double unused = 180.0;
    double area[4], vector[4][3];
    *out_is_flat = !ss_mesh_has_good_nodes(mesh, node, 4);
    for (int c = 0; c < 4; ++c) {
        const int32_t corner[3] = {node[c], node[(c + 1) % 4], node[(c + 3) % 4]};
        (void)measure_corner(mesh, corner, inout_angle);
    }
    ss_mesh_share_quad(mesh, node, area, vector);
    for (int half = 0; half < 2; ++half) {
        *out_is_flat |= measure_corner(mesh, mesh->triangle[2 * q + half], &unused) <= least;
    }
    return area[0] + area[1] + area[2] + area[3];
}

static void check_faces(const ss_mesh *mesh, ss_mesh_report *report)
{
    const bool is_quads = mesh->quad_count > 0;
    const int32_t count = is_quads ? mesh->quad_count : mesh->triangle_count;
    const double parts = mesh->middle != NULL ? 4.0 : 1.0; /* that a face is told in */
    const double least = SS_MESH_FLAT_AREA * report->edge_mean * report->edge_mean / parts;
    report->angle_min = 180.0;
    for (int32_t f = 0; f < count; ++f) {
        const int32_t *node = is_quads ? mesh->quad[f] : mesh->triangle[f];
        if (!indices_are_good(mesh, node, is_quads ? 4 : 3)) {
            ss_mesh_add_fault(&report->bad_index, f);
            continue;
        }
        bool is_flat;
        const double area =
            (is_quads ? check_quad : check_triangle)(mesh, f, least, &report->angle_min, &is_flat);
        report->area += isfinite(area) ? area : 0.0;
        if (is_flat) {
            ss_mesh_add_fault(&report->zero_area, f);
        }
    }
}

/* Equal tuples: all but the first of each run are duplicates. */
static void check_duplicates(const ss_mesh_tuples *elements, ss_mesh_fault *fault)
{
    for (int64_t i = 0; i < elements->count;) {
        const int64_t end = ss_mesh_run_end(elements, i);
        for (int64_t k = i + 1; k < end; ++k) {
            ss_mesh_add_fault(fault, elements->tuple[k].id);
        }
        i = end;
    }
}

/* ---- tetrahedra ---- */

static void check_tetrahedra(const ss_mesh *mesh, ss_mesh_report *report)
{
    const double least =
        SS_MESH_FLAT_VOLUME * report->edge_mean * report->edge_mean * report->edge_mean;
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        const int32_t *node = mesh->tetrahedron[e];
        if (!indices_are_good(mesh, node, 4)) {
            ss_mesh_add_fault(&report->bad_index, e);
            continue;
        }
        const double volume = ss_six_volumes3(mesh->position[node[0]], mesh->position[node[1]],
                                              mesh->position[node[2]], mesh->position[node[3]]) /
                              6.0;
        if (volume < -least) {
            ss_mesh_add_fault(&report->inverted_tetrahedron, e);
        } else if (volume <= least) {
            ss_mesh_add_fault(&report->flat_tetrahedron, e);
        }
    }
}

static double height_sign(const ss_mesh *mesh, const int32_t *face, int32_t node, double least)
{
    const double volume = ss_six_volumes3(mesh->position[face[0]], mesh->position[face[1]],
                                          mesh->position[face[2]], mesh->position[node]) /
                          6.0;
    return volume > least ? 1.0 : volume < -least ? -1.0 : 0.0;
}

/* Two on one side of their face, or more than two of one face. That does not depend on the order of
 * their nodes, so that a node which was moved through its neighbours is told from tetrahedra that
 * were written inverted. */
static void mark_overlaps(const ss_mesh *mesh, const ss_mesh_tuples *faces, double edge_mean,
                          bool *out_is_overlapping)
{
    const double least = SS_MESH_FLAT_VOLUME * edge_mean * edge_mean * edge_mean;
    for (int64_t i = 0; i < faces->count;) {
        const int64_t end = ss_mesh_run_end(faces, i);
        bool is_crowded = end - i > 2;
        if (end - i == 2) {
            double sign[2];
            for (int k = 0; k < 2; ++k) {
                const int32_t id = faces->tuple[i + k].id;
                sign[k] = height_sign(mesh, faces->tuple[i].node, mesh->tetrahedron[id / 4][id % 4],
                                      least);
            }
            is_crowded = sign[0] * sign[1] > 0.0;
        }
        for (int64_t k = i; is_crowded && k < end; ++k) {
            out_is_overlapping[faces->tuple[k].id / 4] = true;
        }
        i = end;
    }
}

bool ss_mesh_mark_overlaps(const ss_mesh *mesh, double edge_mean, bool *out_is_overlapping)
{
    ss_mesh_tuples faces = {0};
    memset(out_is_overlapping, 0, (size_t)mesh->tetrahedron_count * sizeof *out_is_overlapping);
    const bool is_done = ss_mesh_list_tetrahedron_faces(mesh, &faces);
    if (is_done) {
        mark_overlaps(mesh, &faces, edge_mean, out_is_overlapping);
    }
    ss_mesh_tuples_fini(&faces);
    return is_done;
}

static bool check_shared_tetrahedra(const ss_mesh *mesh, ss_mesh_report *report)
{
    ss_mesh_tuples tuples = {0};
    if (!ss_mesh_list_tetrahedra(mesh, &tuples)) {
        return false;
    }
    check_duplicates(&tuples, &report->duplicate_tetrahedron);
    ss_mesh_tuples_fini(&tuples);
    if (!ss_mesh_list_tetrahedron_faces(mesh, &tuples)) {
        return false;
    }
    for (int64_t i = 0; i < tuples.count;) {
        const int64_t end = ss_mesh_run_end(&tuples, i);
        if (end - i > 2) {
            ss_mesh_add_fault(&report->crowded_face, tuples.tuple[i].node[0]);
        }
        i = end;
    }
    bool *is_overlapping = ss_memory_get((size_t)mesh->tetrahedron_count, sizeof *is_overlapping);
    const bool is_done = is_overlapping != NULL;
    if (is_done) {
        mark_overlaps(mesh, &tuples, report->edge_mean, is_overlapping);
    }
    for (int32_t e = 0; e < mesh->tetrahedron_count && is_done; ++e) {
        if (is_overlapping[e]) {
            ss_mesh_add_fault(&report->overlapping_tetrahedron, e);
        }
    }
    ss_memory_free(is_overlapping);
    ss_mesh_tuples_fini(&tuples);
    return is_done;
}

/* ---- second order ---- */

static void list_ten(const ss_mesh *mesh, int32_t e, int32_t out[SS_TETRAHEDRON_NODES])
{
    memcpy(out, mesh->tetrahedron[e], sizeof *mesh->tetrahedron);
    memcpy(out + 4, mesh->middle[e], sizeof *mesh->middle);
}

/* Elements whose corners have a volume, but that are inside out at a Gauss point. */
static void check_bent(const ss_mesh *mesh, ss_mesh_report *report)
{
    const double least =
        SS_MESH_FLAT_VOLUME * report->edge_mean * report->edge_mean * report->edge_mean;
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        int32_t node[SS_TETRAHEDRON_NODES];
        list_ten(mesh, e, node);
        if (!indices_are_good(mesh, node, SS_TETRAHEDRON_NODES)) {
            ss_mesh_add_fault(&report->bad_index, e);
            continue;
        }
        const double volume = ss_six_volumes3(mesh->position[node[0]], mesh->position[node[1]],
                                              mesh->position[node[2]], mesh->position[node[3]]) /
                              6.0;
        bool is_bent = false;
        for (int q = 0; q < SS_TETRAHEDRON_POINTS; ++q) {
            double unused[4][3];
            is_bent = is_bent || !(ss_tetrahedron_point((const double(*)[3])mesh->position, node, q,
                                                        unused) > 0.0);
        }
        if (is_bent && volume > least) {
            ss_mesh_add_fault(&report->bent_tetrahedron, e);
        }
    }
}

enum { AT_NONE = -1, AT_CORNER = -2 }; /* else the edge that a node is the middle of */

/* `place`: of each node. */
static void check_mid_edge_nodes(const ss_mesh *mesh, const ss_mesh_tuples *edges, int32_t *place,
                                 ss_mesh_report *report)
{
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        place[i] = AT_NONE;
    }
    for (int32_t c = 0; c < 4 * mesh->tetrahedron_count; ++c) {
        const int32_t node = mesh->tetrahedron[c / 4][c % 4];
        if (indices_are_good(mesh, &node, 1)) {
            place[node] = AT_CORNER;
        }
    }
    for (int64_t i = 0; i < edges->count;) {
        const int64_t end = ss_mesh_run_end(edges, i);
        bool is_parted = false;
        int32_t before = -1;
        for (int64_t k = i; k < end; ++k) {
            const int32_t node = mesh->middle[edges->tuple[k].id / 6][edges->tuple[k].id % 6];
            is_parted = is_parted || (k > i && node != before);
            if (node != before && indices_are_good(mesh, &node, 1)) {
                if (place[node] != AT_NONE && place[node] != edges->tuple[i].id) {
                    ss_mesh_add_fault(&report->shared_middle, node);
                }
                place[node] = place[node] == AT_NONE ? edges->tuple[i].id : place[node];
            }
            before = node;
        }
        if (is_parted) {
            ss_mesh_add_fault(&report->parted_side, edges->tuple[i].node[0]);
        }
        i = end;
    }
}

static bool check_second_order(const ss_mesh *mesh, ss_mesh_report *report)
{
    ss_mesh_tuples edges = {0};
    int32_t *place = ss_memory_get((size_t)mesh->node_count, sizeof *place);
    const bool is_done = place != NULL && ss_mesh_list_tetrahedron_edges(mesh, &edges);
    if (is_done) {
        check_mid_edge_nodes(mesh, &edges, place, report);
        if (report->parted_side.count == 0 && report->shared_middle.count == 0) {
            check_bent(mesh, report);
        }
    }
    ss_mesh_tuples_fini(&edges);
    ss_memory_free(place);
    return is_done;
}

/* Where a wrong node is in the middle of an edge, the surface has holes and folds and the right one
 * has no element: one fault is told, not its consequences. */
static void forget_consequences(ss_mesh_report *report)
{
    static const ss_mesh_fault none = {0};
    if (report->parted_side.count > 0 || report->shared_middle.count > 0) {
        report->loose_node = report->zero_area = report->open_edge = none;
        report->non_manifold_edge = report->non_manifold_node = none;
        report->pinched_edge = report->pinched_node = none;
        report->inconsistent_winding = report->duplicate_triangle = none;
    }
}

/* ---- all of it ---- */

static bool check_parts(const ss_mesh *mesh, const ss_mesh_tuples *edges, ss_mesh_report *report)
{
    int32_t *part = ss_memory_get((size_t)mesh->node_count, sizeof *part);
    ss_mesh_part *parts = NULL;
    bool is_done = false;
    const int32_t count = part != NULL ? ss_mesh_find_parts(mesh, true, part) : -1;
    if (count >= 0) {
        report->component_count = count;
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            if (part[i] < 0) {
                ss_mesh_add_fault(&report->loose_node, i);
            }
        }
        /* Cavities of a volume are shells of their own: parts of the surface alone. */
        const int32_t shells = ss_mesh_find_parts(mesh, false, part);
        parts = shells >= 0 ? ss_memory_get((size_t)shells, sizeof *parts) : NULL;
        is_done = parts != NULL;
        if (is_done) {
            report->is_inside_out = ss_mesh_measure_parts(mesh, part, shells, edges, parts, NULL);
            for (int32_t p = 0; p < shells; ++p) {
                report->volume += parts[p].volume;
            }
        }
    }
    ss_memory_free(parts);
    ss_memory_free(part);
    return is_done;
}

static bool check_surface_edges(const ss_mesh *mesh, const ss_mesh_tuples *edges,
                                ss_mesh_report *report)
{
    int32_t *corner_set = ss_memory_get(3 * (size_t)mesh->triangle_count, sizeof *corner_set);
    int32_t *twin = ss_memory_get(3 * (size_t)mesh->triangle_count, sizeof *twin);
    int32_t *fans = ss_memory_get((size_t)mesh->node_count, sizeof *fans);
    int32_t unpaired;
    const bool is_done = corner_set != NULL && twin != NULL && fans != NULL &&
                         ss_mesh_pair_sides(mesh, twin, &unpaired);
    if (is_done) {
        check_edges(mesh, edges, twin, corner_set, report);
        check_fans(mesh, corner_set, fans, report);
    }
    SS_EACH(ss_memory_free, corner_set, twin, fans);
    return is_done;
}

static bool measure_mean_edge(const ss_mesh *mesh, const ss_mesh_tuples *edges,
                              ss_mesh_report *report)
{
    if (mesh->tetrahedron_count == 0 && mesh->quad_count == 0) {
        measure_edges(mesh, edges, report);
        return true;
    }
    ss_mesh_tuples own = {0};
    if (mesh->quad_count > 0 ? !ss_mesh_list_quad_edges(mesh, &own)
                             : !ss_mesh_list_tetrahedron_edges(mesh, &own)) {
        return false;
    }
    measure_edges(mesh, &own, report);
    for (int64_t i = 0; i < own.count && mesh->quad_count > 0;) {
        const int64_t end = ss_mesh_run_end(&own, i);
        if (end - i == 2 && ((own.tuple[i].id ^ own.tuple[i + 1].id) & 1) != 0) {
            ss_mesh_add_fault(&report->mixed_direction, own.tuple[i].node[0]);
        }
        i = end;
    }
    ss_mesh_tuples_fini(&own);
    return true;
}

softsim_status ss_mesh_check(const ss_mesh *mesh, ss_mesh_report *out_report)
{
    *out_report = (ss_mesh_report){0};
    ss_mesh_tuples edges = {0};
    ss_mesh_tuples elements = {0};
    const bool has_quads = mesh->quad_count > 0;
    check_positions(mesh, out_report);
    const bool is_done =
        ss_mesh_list_triangle_edges(mesh, &edges) &&
        (has_quads ? ss_mesh_list_quads(mesh, &elements)
                   : ss_mesh_list_triangles(mesh, &elements)) &&
        measure_mean_edge(mesh, &edges, out_report) &&
        check_surface_edges(mesh, &edges, out_report) && find_coincident(mesh, out_report) &&
        check_parts(mesh, &edges, out_report) && check_shared_tetrahedra(mesh, out_report) &&
        (mesh->middle == NULL || check_second_order(mesh, out_report));
    if (is_done) {
        check_faces(mesh, out_report);
        check_duplicates(&elements, &out_report->duplicate_triangle);
        check_tetrahedra(mesh, out_report);
        forget_consequences(out_report);
    }
    ss_mesh_tuples_fini(&edges);
    ss_mesh_tuples_fini(&elements);
    return is_done ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}
