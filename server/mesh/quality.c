/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Shapes of elements, and holes.
 *
 * The dihedral angle of a tetrahedron at an edge lies between the two faces there: with outward
 * normals n, cos = -n_f . n_g. The stiffest mode of a linear element, and with it the stable step,
 * goes as the reciprocal of its least height; interpolation errors as 1 / sin of its largest angle
 * (Shewchuk 2002): both are judged. Measures that mix the two into one number (radius ratios, mean
 * ratio) were rejected: they tell neither.
 */
#include "mesh/mesh.h"
#include "mesh/topology.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

static const double degrees = 180.0 / SS_PI;
static const double sharp_angle = 10.0; /* degrees */
static const double longest_shape = 20.0;

typedef struct shape {
    double least, largest; /* angles, degrees */
    double length;         /* longest edge / least height; 0 where it is not judged */
} shape;

/* False for elements that cannot be measured. */
static bool measure_tetrahedron(const ss_mesh *mesh, const int32_t *node, shape *out)
{
    double normal[4][3];
    double area = 0.0; /* twice the largest face's */
    double first_area = 0.0;
    double longest = 0.0;
    for (int f = 0; f < 4; ++f) {
        /* Corners so that the normals point the same way, all outward or all inward. */
        const int first = f % 2 == 0 ? (f + 1) % 4 : (f + 2) % 4;
        const int second = f % 2 == 0 ? (f + 2) % 4 : (f + 1) % 4;
        double u[3], v[3];
        ss_sub3(u, mesh->position[node[second]], mesh->position[node[first]]);
        ss_sub3(v, mesh->position[node[(f + 3) % 4]], mesh->position[node[first]]);
        ss_cross3(normal[f], u, v);
        longest = fmax(longest, fmax(ss_norm3(u), ss_norm3(v)));
        const double size = ss_normalize3(normal[f]);
        area = fmax(area, size);
        first_area = f == 0 ? size : first_area;
    }
    /* Face 0's normal across the edge 1-0: the volume. The edge 0-2 is in none of the u and v. */
    double edge[3];
    ss_sub3(edge, mesh->position[node[2]], mesh->position[node[0]]);
    longest = fmax(longest, ss_norm3(edge));
    ss_sub3(edge, mesh->position[node[1]], mesh->position[node[0]]);
    const double six_volumes = fabs(ss_dot3(normal[0], edge)) * first_area;
    if (!(six_volumes > 0.0) || !isfinite(six_volumes)) {
        return false;
    }
    *out = (shape){.least = 180.0, .length = longest * area / six_volumes};
    for (int f = 0; f < 4; ++f) {
        for (int g = 0; g < f; ++g) {
            const double cosine = fmax(-1.0, fmin(1.0, -ss_dot3(normal[f], normal[g])));
            const double angle = degrees * acos(cosine);
            out->least = fmin(out->least, angle);
            out->largest = fmax(out->largest, angle);
        }
    }
    return true;
}

/* A triangle, or a quad by its corners. */
static bool measure_face(const ss_mesh *mesh, const int32_t *node, int corners, shape *out)
{
    *out = (shape){.least = 180.0};
    for (int c = 0; c < corners; ++c) {
        double u[3], v[3], across[3];
        const double *x = mesh->position[node[c]];
        ss_sub3(u, mesh->position[node[(c + 1) % corners]], x);
        ss_sub3(v, mesh->position[node[(c + corners - 1) % corners]], x);
        ss_cross3(across, u, v);
        const double sine = ss_norm3(across);
        if (!(sine > 0.0) || !isfinite(sine)) {
            return false;
        }
        out->least = fmin(out->least, degrees * atan2(sine, ss_dot3(u, v)));
    }
    return true;
}

void ss_mesh_measure_quality(const ss_mesh *mesh, ss_mesh_quality *out)
{
    *out = (ss_mesh_quality){0};
    const bool has_tetrahedra = mesh->tetrahedron_count > 0;
    const int corners = has_tetrahedra || mesh->quad_count > 0 ? 4 : 3;
    out->dihedral_min = has_tetrahedra ? 180.0 : 0.0;
    for (int32_t e = 0; e < ss_mesh_element_count(mesh); ++e) {
        const int32_t *node = has_tetrahedra         ? mesh->tetrahedron[e]
                              : mesh->quad_count > 0 ? mesh->quad[e]
                                                     : mesh->triangle[e];
        shape s;
        if (!ss_mesh_has_good_nodes(mesh, node, corners) ||
            !(has_tetrahedra ? measure_tetrahedron(mesh, node, &s)
                             : measure_face(mesh, node, corners, &s))) {
            continue;
        }
        const int bin = (int)(s.least / (90.0 / SS_MESH_ANGLE_BINS));
        ++out->histogram[bin < SS_MESH_ANGLE_BINS ? bin : SS_MESH_ANGLE_BINS - 1];
        if (has_tetrahedra) {
            out->dihedral_min = fmin(out->dihedral_min, s.least);
            out->dihedral_max = fmax(out->dihedral_max, s.largest);
        }
        if (s.least < sharp_angle || s.largest > 180.0 - sharp_angle || s.length > longest_shape) {
            ss_mesh_add_fault(&out->sliver, e);
        }
    }
}

bool ss_mesh_find_holes(const ss_mesh *mesh, ss_mesh_fault *out_hole)
{
    *out_hole = (ss_mesh_fault){0};
    ss_mesh_tuples edges = {0};
    int32_t *loop = ss_memory_get((size_t)mesh->node_count, sizeof *loop);
    bool *is_open = ss_memory_get((size_t)mesh->node_count, sizeof *is_open);
    const bool is_good =
        loop != NULL && is_open != NULL && ss_mesh_list_triangle_edges(mesh, &edges);
    if (is_good) {
        ss_mesh_union_init(loop, mesh->node_count);
        for (int64_t i = 0; i < edges.count;) {
            const int64_t end = ss_mesh_run_end(&edges, i);
            if (end - i == 1) {
                const int32_t *node = edges.tuple[i].node;
                ss_mesh_union_join(loop, node[0], node[1]);
                is_open[node[0]] = true;
                is_open[node[1]] = true;
            }
            i = end;
        }
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            if (is_open[i] && ss_mesh_union_find(loop, i) == i) {
                ss_mesh_add_fault(out_hole, i);
            }
        }
        ss_mesh_tuples_fini(&edges);
    }
    ss_memory_free(loop);
    ss_memory_free(is_open);
    return is_good;
}

bool ss_mesh_mark_open(const ss_mesh *mesh, bool *out_is_open)
{
    ss_mesh_tuples edges = {0};
    memset(out_is_open, 0, (size_t)mesh->triangle_count * sizeof *out_is_open);
    if (!ss_mesh_list_triangle_edges(mesh, &edges)) {
        return false;
    }
    for (int64_t i = 0; i < edges.count;) {
        const int64_t end = ss_mesh_run_end(&edges, i);
        if (end - i == 1) {
            out_is_open[edges.tuple[i].id / 3] = true;
        }
        i = end;
    }
    ss_mesh_tuples_fini(&edges);
    return true;
}
