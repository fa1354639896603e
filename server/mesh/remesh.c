/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Isotropic remeshing (Botsch & Kobbelt 2004): again and again, edges longer than 4/3 L are divided
 * in the middle, nodes of edges shorter than 4/5 L go, edges are flipped where that brings the
 * number of neighbours nearer to 6 (4 on a border), and nodes move to the mean of their neighbours
 * in their tangent plane, and back to the nearest point of the surface as it was given. Edges
 * sharper than an angle, and borders, are features: they are divided and shortened along
 * themselves alone, and their nodes do not move.
 *
 * What operations (remesh_edges.c) cannot see, sheets that come to cross, is looked for after each
 * round: then the round is undone, and done again without the nodes near there.
 *
 * Remeshing from a signed distance was rejected: it closes what is open, and loses features.
 */
#include "mesh/remesher.h"
#include "mesh/topology.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <string.h>

enum { ROUNDS = 10, RETRIES = 4, MAX_GROUPS = 64, MAX_LOOKS = 4096 };
static const double least_feature = 4.0;  /* edges, in all */
static const double splinter_deg = 10.0;  /* as a sliver's angle (quality.c) */
static const double most_triangles = 4e6; /* by the area */

/* ---- rounds ---- */

/* Is no other side of its triangle longer? */
static bool is_longest(const ss_remesher *r, int32_t id)
{
    const double own = ss_remesher_length(r, ss_start_of(r, id), ss_end_of(r, id));
    return own >= ss_remesher_length(r, ss_end_of(r, id), ss_third_of(r, id)) &&
           own >= ss_remesher_length(r, ss_third_of(r, id), ss_start_of(r, id));
}

/* Until none is too long, the longest of both triangles first, which keeps angles (Rivara 1984):
 * what moves before would be squeezed against features whose nodes are far apart. */
static bool divide_long(ss_remesher *r)
{
    for (int32_t before = -1; before != r->triangle_count;) {
        before = r->triangle_count;
        for (int32_t id = 0; id < 3 * before; ++id) {
            const int32_t a = ss_start_of(r, id), b = ss_end_of(r, id);
            if (!r->is_locked[a] && !r->is_locked[b] &&
                ss_remesher_length(r, a, b) > SS_REMESH_TOO_LONG * r->edge && is_longest(r, id) &&
                (r->mate[id] < 0 || is_longest(r, r->mate[id])) && !ss_remesh_divide(r, id)) {
                return false;
            }
        }
    }
    return true;
}

static void collapse_short(ss_remesher *r)
{
    for (int32_t id = 0; id < 3 * r->triangle_count; ++id) {
        if (r->triangle[id / 3][0] < 0) {
            continue;
        }
        const int32_t a = ss_start_of(r, id), b = ss_end_of(r, id);
        if (!r->is_locked[a] && !r->is_locked[b] &&
            ss_remesher_length(r, a, b) < SS_REMESH_TOO_SHORT * r->edge) {
            ss_remesh_collapse(r, id);
        }
    }
}

static void flip_edges(ss_remesher *r)
{
    for (int32_t id = 0; id < 3 * r->triangle_count; ++id) {
        if (r->mate[id] > id) {
            ss_remesh_flip(r, id);
        }
    }
}

/* To the mean of the triangles around it, weighted by area, in its tangent plane, and back to the
 * surface. */
static void smooth_node(ss_remesher *r, int32_t node)
{
    ss_ring g;
    double mean[3] = {0}, normal[3] = {0}, to[3], back[3];
    double area = 0.0;
    if (!ss_remesher_gather(r, node, &g) || g.features > 0 || g.is_open) {
        return;
    }
    for (int i = 0; i < g.count; ++i) {
        const double *b = r->x[ss_end_of(r, g.side[i])], *c = r->x[ss_third_of(r, g.side[i])];
        double own[3], middle[3];
        ss_normal3(own, r->x[node], b, c);
        const double weight = ss_norm3(own);
        ss_add3(normal, normal, own);
        ss_add3(middle, b, c);
        ss_add3(middle, middle, r->x[node]);
        ss_madd3(mean, mean, weight / 3.0, middle);
        area += weight;
    }
    if (!(area > 0.0) || !(ss_normalize3(normal) > 0.0)) {
        return;
    }
    ss_scale3(mean, mean, 1.0 / area);
    ss_sub3(to, mean, r->x[node]);
    ss_madd3(to, mean, -ss_dot3(to, normal), normal);
    int32_t t = -1;
    const double off = ss_tree_nearest(&r->tree, r->given, to, back, &t);
    if (!(off < 0.5 * r->edge)) {
        return;
    }
    double there[3];
    const int32_t *n = r->given->triangle[t];
    ss_normal3(there, r->given->position[n[0]], r->given->position[n[1]], r->given->position[n[2]]);
    bool is_good = ss_dot3(there, normal) > 0.0; /* else another sheet's */
    for (int i = 0; i < g.count && is_good; ++i) {
        is_good = !ss_remesh_turns_over(r, g.side[i], back, 1.0);
    }
    if (is_good) {
        ss_copy3(r->x[node], back);
    }
}

static bool run_round(ss_remesher *r)
{
    if (!divide_long(r)) {
        return false;
    }
    collapse_short(r);
    if (!ss_remesher_rebuild(r)) {
        return false;
    }
    for (int pass = 0; pass < 2; ++pass) {
        flip_edges(r);
        for (int32_t i = 0; i < r->node_count; ++i) {
            if (!r->is_locked[i]) {
                smooth_node(r, i);
            }
        }
    }
    return ss_remesher_rebuild(r);
}

/* ---- undoing ---- */

typedef struct locking {
    const ss_remesher *now;
    ss_remesher *kept;
    ss_box *box; /* of the triangles that cross, and around them */
    int32_t count, node;
} locking;

static void lock_node(void *what, int32_t item)
{
    (void)item;
    locking *l = what;
    l->kept->is_locked[l->node] = true;
}

static bool list_crossings(locking *l, bool *inout_is_complete)
{
    const ss_remesher *r = l->now;
    const ss_mesh view = {.node_count = r->node_count,
                          .position = r->x,
                          .triangle_count = r->triangle_count,
                          .triangle = r->triangle};
    bool is_complete = true;
    bool *is_crossing = ss_memory_get((size_t)r->triangle_count, sizeof *is_crossing);
    l->box = ss_memory_get((size_t)r->triangle_count, sizeof *l->box);
    const bool is_good = is_crossing != NULL && l->box != NULL &&
                         ss_mesh_mark_crossings(&view, is_crossing, &is_complete);
    for (int32_t t = 0; t < r->triangle_count && is_good; ++t) {
        ss_box *box = &l->box[l->count];
        if (is_crossing[t] && ss_box_of_triangle(&view, t, box)) {
            for (int k = 0; k < 3; ++k) {
                box->low[k] -= 1.5 * r->edge;
                box->high[k] += 1.5 * r->edge;
            }
            ++l->count;
        }
    }
    ss_memory_free(is_crossing);
    *inout_is_complete = *inout_is_complete && is_complete;
    return is_good;
}

/* Locks the nodes of `kept` near the triangles of `r` that cross others; how many cross, -1 when
 * out of memory. */
static int32_t lock_crossings(const ss_remesher *r, ss_remesher *kept, bool *inout_is_complete)
{
    locking l = {.now = r, .kept = kept};
    ss_tree tree = {0};
    const bool is_good = list_crossings(&l, inout_is_complete) &&
                         (l.count == 0 || ss_tree_init(&tree, l.box, l.count));
    for (l.node = 0; l.node < kept->node_count && is_good && l.count > 0; ++l.node) {
        ss_box point;
        int64_t visits = MAX_LOOKS;
        ss_box_init(&point);
        ss_box_add(&point, kept->x[l.node]);
        ss_tree_visit(&tree, &point, &visits, lock_node, &l);
        kept->is_locked[l.node] = kept->is_locked[l.node] || visits <= 0;
    }
    ss_tree_fini(&tree);
    ss_memory_free(l.box);
    return is_good ? l.count : -1;
}

/* False when out of memory, or full. */
static bool run_rounds(ss_remesher *r, ss_mesh_remeshing *out)
{
    ss_remesher kept = {0};
    bool is_good = true;
    for (int round = 0; round < ROUNDS && is_good; ++round) {
        is_good = ss_remesher_copy(r, &kept);
        for (int retry = 0; is_good; ++retry) {
            is_good = run_round(r);
            const int32_t crossing =
                is_good ? lock_crossings(r, &kept, &out->is_crossing_complete) : -1;
            is_good = is_good && crossing >= 0;
            if (crossing <= 0) {
                break;
            }
            ++out->undone_rounds;
            is_good = is_good && ss_remesher_copy(&kept, r);
            if (retry == RETRIES) {
                round = ROUNDS;
                break;
            }
        }
        out->rounds += round < ROUNDS;
    }
    for (int32_t i = 0; i < r->node_count && is_good; ++i) {
        out->locked_nodes += r->is_locked[i];
    }
    ss_remesher_fini(&kept);
    return is_good;
}

/* ---- in and out ---- */

static void forget_feature(ss_remesher *r, int32_t id)
{
    r->is_feature[id] = r->is_feature[r->mate[id]] = false;
}

/* Two features that meet at less than ten degrees in one triangle are no edges of a body, but the
 * sides of a sliver, as filled holes leave them: its normal points anywhere. They would keep it. */
static void forget_splinters(ss_remesher *r)
{
    for (int32_t id = 0; id < 3 * r->triangle_count; ++id) {
        const int32_t before = ss_last_side(id);
        double u[3], v[3], across[3];
        ss_sub3(u, r->x[ss_end_of(r, id)], r->x[ss_start_of(r, id)]);
        ss_sub3(v, r->x[ss_third_of(r, id)], r->x[ss_start_of(r, id)]);
        ss_cross3(across, u, v);
        const double angle = atan2(ss_norm3(across), ss_dot3(u, v));
        if (r->is_feature[id] && r->is_feature[before] && r->mate[id] >= 0 &&
            r->mate[before] >= 0 && angle < splinter_deg * SS_PI / 180.0) {
            forget_feature(r, id);
            forget_feature(r, before);
        }
    }
}

/* Features that are connected and together shorter than a few edges are bumps, which edges of that
 * length cannot have; they come of filled holes too. Borders stay. */
static bool forget_bumps(ss_remesher *r)
{
    int32_t *parent = ss_memory_get((size_t)r->node_count, sizeof *parent);
    double *length = ss_memory_get((size_t)r->node_count, sizeof *length);
    const bool is_good = parent != NULL && length != NULL;
    if (is_good) {
        ss_mesh_union_init(parent, r->node_count);
    }
    for (int32_t id = 0; id < 3 * r->triangle_count && is_good; ++id) {
        if (r->is_feature[id]) {
            ss_mesh_union_join(parent, ss_start_of(r, id), ss_end_of(r, id));
        }
    }
    for (int32_t id = 0; id < 3 * r->triangle_count && is_good; ++id) {
        if (r->is_feature[id] && r->mate[id] < id) {
            length[ss_mesh_union_find(parent, ss_start_of(r, id))] +=
                r->mate[id] < 0 ? INFINITY
                                : ss_remesher_length(r, ss_start_of(r, id), ss_end_of(r, id));
        }
    }
    for (int32_t id = 0; id < 3 * r->triangle_count && is_good; ++id) {
        if (r->is_feature[id] &&
            length[ss_mesh_union_find(parent, ss_start_of(r, id))] < least_feature * r->edge) {
            forget_feature(r, id);
        }
    }
    SS_EACH(ss_memory_free, parent, length);
    return is_good;
}

static bool take_given(ss_remesher *r, double feature_deg)
{
    const ss_mesh *m = r->given;
    const size_t nodes = (size_t)m->node_count, triangles = (size_t)m->triangle_count;
    if (!ss_remesher_init(r, m->node_count, m->triangle_count)) {
        return false;
    }
    memcpy(r->x, m->position, nodes * sizeof *r->x);
    memcpy(r->triangle, m->triangle, triangles * sizeof *r->triangle);
    for (int32_t g = 0; g < m->group_count; ++g) {
        for (int32_t i = 0; i < m->group[g].node_count; ++i) {
            r->groups[m->group[g].node[i]] |= (uint64_t)1 << g;
        }
    }
    if (!ss_remesher_rebuild(r)) {
        return false;
    }
    const double least = cos(feature_deg * SS_PI / 180.0);
    for (int32_t id = 0; id < 3 * r->triangle_count; ++id) {
        double normal[2][3];
        const int32_t side[2] = {id, r->mate[id]};
        for (int k = 0; k < 2 && side[1] >= 0; ++k) {
            const int32_t *n = r->triangle[side[k] / 3];
            ss_normal3(normal[k], r->x[n[0]], r->x[n[1]], r->x[n[2]]);
            (void)ss_normalize3(normal[k]);
        }
        r->is_feature[id] = side[1] < 0 || ss_dot3(normal[0], normal[1]) < least;
    }
    forget_splinters(r);
    return forget_bumps(r);
}

static softsim_status give(const ss_remesher *r, ss_mesh **out, softsim_error *error)
{
    const ss_mesh *m = r->given;
    softsim_status status =
        ss_mesh_create(r->node_count, (const double(*)[3])r->x, r->triangle_count,
                       (const int32_t(*)[3])r->triangle, 0, NULL, out, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    (*out)->group = ss_memory_get((size_t)m->group_count, sizeof *(*out)->group);
    status = (*out)->group != NULL ? status : SOFTSIM_ERROR_MEMORY;
    for (int32_t g = 0; g < m->group_count && status == SOFTSIM_OK; ++g) {
        ss_mesh_group *group = &(*out)->group[g];
        memcpy(group->name, m->group[g].name, sizeof group->name);
        group->node = ss_memory_get((size_t)r->node_count, sizeof *group->node);
        for (int32_t i = 0; i < r->node_count && group->node != NULL; ++i) {
            if ((r->groups[i] >> g & 1) != 0) {
                group->node[group->node_count++] = i;
            }
        }
        (*out)->group_count += group->node != NULL;
        status = group->node != NULL ? status : SOFTSIM_ERROR_MEMORY;
    }
    return status;
}

/* The greatest distance of nodes and middles of triangles of one from the other. */
static bool measure_distance(const ss_mesh *from, const ss_mesh *to, double *inout_most)
{
    ss_tree tree;
    if (!ss_tree_init_triangles(&tree, to)) {
        return false;
    }
    for (int32_t i = 0; i < from->node_count + from->triangle_count; ++i) {
        double x[3], nearest[3];
        int32_t t;
        if (i < from->node_count) {
            ss_copy3(x, from->position[i]);
        } else {
            const int32_t *n = from->triangle[i - from->node_count];
            ss_add3(x, from->position[n[0]], from->position[n[1]]);
            ss_add3(x, x, from->position[n[2]]);
            ss_scale3(x, x, 1.0 / 3.0);
        }
        *inout_most = fmax(*inout_most, ss_tree_nearest(&tree, to, x, nearest, &t));
    }
    ss_tree_fini(&tree);
    return true;
}

static softsim_status refuse(softsim_error *error, const char *why)
{
    softsim_error_add(error, SOFTSIM_ERROR_MESH, "%s", why);
    return SOFTSIM_ERROR_MESH;
}

softsim_status ss_mesh_remesh(const ss_mesh *mesh, double edge, double feature_deg,
                              ss_mesh **out_mesh, ss_mesh_remeshing *out, softsim_error *error)
{
    *out_mesh = NULL;
    *out = (ss_mesh_remeshing){.is_crossing_complete = true};
    ss_mesh_report report;
    ss_mesh_finding found[SS_MESH_MAX_FINDINGS];
    ss_mesh_fault crossing;
    bool is_refused = false;
    ss_remesher r = {.given = mesh, .edge = edge};
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (mesh->tetrahedron_count > 0) {
        return refuse(error, "it has tetrahedra: give its surface (softsim-mesh convert IN "
                             "surface.obj), and fill that again");
    }
    if (mesh->group_count > MAX_GROUPS) {
        return refuse(error, "it has more than 64 groups: leave those out that are not needed");
    }
    if (ss_mesh_check(mesh, &report) == SOFTSIM_OK &&
        ss_mesh_find_crossings(mesh, &crossing, &out->is_crossing_complete)) {
        const int32_t count = ss_mesh_list_findings(mesh, &report, found);
        for (int32_t i = 0; i < count; ++i) {
            is_refused = is_refused || !found[i].is_harmless;
        }
        if (is_refused || crossing.count > 0) {
            return refuse(error,
                          crossing.count > 0
                              ? "triangles cross others: move them apart in the program that "
                                "made it (a boolean union, or a remesh by voxels, does "
                                "that); softsim-mesh check tells which"
                              : "mend it first: softsim-mesh convert --repair");
        }
        if (report.area / (0.433 * edge * edge) > most_triangles) {
            return refuse(error, "more than 4 million triangles: give a longer edge");
        }
        status = ss_tree_init_triangles(&r.tree, mesh) && take_given(&r, feature_deg) &&
                         run_rounds(&r, out)
                     ? give(&r, out_mesh, error)
                     : SOFTSIM_ERROR_MEMORY;
    }
    if (r.is_full) {
        status = refuse(error, "more than 8 million triangles, for its own are long and thin: give "
                               "a longer edge");
    }
    if (status == SOFTSIM_OK && !(measure_distance(mesh, *out_mesh, &out->distance) &&
                                  measure_distance(*out_mesh, mesh, &out->distance))) {
        status = SOFTSIM_ERROR_MEMORY;
    }
    if (status != SOFTSIM_OK) {
        ss_mesh_destroy(out_mesh);
    }
    if (status == SOFTSIM_ERROR_MEMORY) {
        softsim_error_add(error, status, "out of memory while remeshing");
    }
    ss_remesher_fini(&r);
    return status;
}
