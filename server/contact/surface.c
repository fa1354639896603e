/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The contact surface of a mesh: where its samples lie, and the tree of boxes that finds them.
 *
 * Tree: complete and binary, without pointers; leaf k of L (a power of two) holds the triangles
 * k T/L .. (k+1) T/L - 1 of an order made once by median splits of the rest centroids along the
 * longest axis. A leaf's box bounds the *control* nodes of its triangles, in whose convex hull the
 * samples lie however the tissue deforms; a refit is one pass over the leaves' distinct nodes and
 * one over the inner boxes. Rejected: boxes of the samples themselves (fifty times the work), and
 * a rebuilt tree (an order that changes would change the order of sums, hence bits).
 *
 * Samples: facets of level 2 are split into m^2 similar parts, a sample at each centroid, so that
 * the spacing is about h/(4 m), h the mean edge. Force ripple follows from the number of samples
 * in contact: m = 3 for R < h/2, 2 for R < 3 h, else 1.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "contact/surface.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* Below this R/h a tool slips between the samples' supports, whatever their number. */
static const double least_radius_per_edge = 0.3;

/* Boxes are kept, and queries widened, until a node has moved so many mean edges: half of half a
 * touch's slack (a quarter of its reach, a mean edge or more), so that a broad phase lasts as long
 * as the boxes do. At 50 mm/s and 2 kHz one fit in ten steps (1212 nodes: 11 us, else 1.2 us). */
static const double stale_motion = 0.0625;

/* ---- sample grid ---- */

static uint8_t grid_index(int i, int j)
{
    return (uint8_t)(5 * j - j * (j - 1) / 2 + i);
}

/* Weights of the centroids of the m^2 parts of a facet. */
static void set_parts(ss_grid *grid, int m)
{
    int count = 0;
    for (int j = 0; j < m; ++j) {
        for (int i = 0; i + j < m; ++i) {
            for (int down = 0; down < (i + j + 1 < m ? 2 : 1); ++down) {
                const double shift = down ? 2.0 / 3.0 : 1.0 / 3.0;
                const double x = (i + shift) / m;
                const double y = (j + shift) / m;
                grid->part[count][0] = (ss_real)(1.0 - x - y);
                grid->part[count][1] = (ss_real)x;
                grid->part[count][2] = (ss_real)y;
                count++;
            }
        }
    }
    grid->part_count = count;
}

static void set_grid(ss_grid *grid, int parts)
{
    if (parts == SS_SURFACE_CENTROIDS) {
        grid->facet_count = 1;
        grid->weight_count = 1;
        for (int k = 0; k < 3; ++k) {
            grid->facet[0][k] = (uint8_t)k;
            grid->bary[k][k] = 1;
            grid->corner[k] = (uint8_t)k;
        }
        set_parts(grid, 1);
        return;
    }
    grid->weight_count = 4;
    grid->corner[0] = grid_index(0, 0);
    grid->corner[1] = grid_index(4, 0);
    grid->corner[2] = grid_index(0, 4);
    for (int j = 0; j <= 4; ++j) {
        for (int i = 0; i + j <= 4; ++i) {
            ss_real *bary = grid->bary[grid_index(i, j)];
            bary[0] = (ss_real)(4 - i - j) / 4;
            bary[1] = (ss_real)i / 4;
            bary[2] = (ss_real)j / 4;
            for (int down = 0; down < 2; ++down) {
                if (i + j + 1 + down <= 4) {
                    uint8_t *facet = grid->facet[grid->facet_count++];
                    facet[0] = down ? grid_index(i + 1, j) : grid_index(i, j);
                    facet[1] = down ? grid_index(i + 1, j + 1) : grid_index(i + 1, j);
                    facet[2] = grid_index(i, j + 1);
                }
            }
        }
    }
    set_parts(grid, parts);
}

/* ---- tree ---- */

typedef struct sorter {
    int32_t *order;
    const double (*key)[3]; /* centroids */
    int axis;
} sorter;

static bool is_before(const sorter *s, int32_t a, int32_t b)
{
    const double ka = s->key[a][s->axis];
    const double kb = s->key[b][s->axis];
    return ka < kb || (!(kb < ka) && a < b);
}

/* Quickselect: afterwards order[first..middle) come before order[middle..end). */
static void split_at(const sorter *s, int32_t first, int32_t end, int32_t middle)
{
    int32_t *order = s->order;
    while (end - first > 1) {
        const int32_t pivot = order[first + (end - first) / 2];
        int32_t i = first;
        int32_t j = end - 1;
        while (i <= j) {
            while (is_before(s, order[i], pivot)) {
                i++;
            }
            while (is_before(s, pivot, order[j])) {
                j--;
            }
            if (i <= j) {
                const int32_t swap = order[i];
                order[i++] = order[j];
                order[j--] = swap;
            }
        }
        if (middle <= j) {
            end = j + 1;
        } else if (middle >= i) {
            first = i;
        } else {
            return;
        }
    }
}

static int longest_axis(const sorter *s, int32_t first, int32_t end)
{
    double low[3] = {DBL_MAX, DBL_MAX, DBL_MAX};
    double high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    for (int32_t i = first; i < end; ++i) {
        for (int k = 0; k < 3; ++k) {
            low[k] = fmin(low[k], s->key[s->order[i]][k]);
            high[k] = fmax(high[k], s->key[s->order[i]][k]);
        }
    }
    int axis = 0;
    for (int k = 1; k < 3; ++k) {
        axis = high[k] - low[k] > high[axis] - low[axis] ? k : axis;
    }
    return axis;
}

/* Orders the triangles so that the leaves' ranges are compact. */
static void sort_triangles(const ss_surface *surface, sorter *s)
{
    for (int32_t span = surface->leaf_count; span > 1; span /= 2) {
        for (int32_t leaf = 0; leaf < surface->leaf_count; leaf += span) {
            const int32_t first = ss_leaf_first_triangle(surface, leaf);
            const int32_t end = ss_leaf_first_triangle(surface, leaf + span);
            s->axis = longest_axis(s, first, end);
            split_at(s, first, end, ss_leaf_first_triangle(surface, leaf + span / 2));
        }
    }
}

static softsim_status order_triangles(const ss_surface *surface, const ss_mesh *mesh,
                                      int32_t *order)
{
    double(*centroid)[3] = ss_memory_get((size_t)mesh->triangle_count, sizeof *centroid);
    if (centroid == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        order[t] = t;
        for (int k = 0; k < 3; ++k) {
            ss_madd3(centroid[t], centroid[t], 1.0 / 3.0, mesh->position[mesh->triangle[t][k]]);
        }
    }
    sorter s = {.order = order, .key = (const double(*)[3])centroid};
    sort_triangles(surface, &s);
    ss_memory_free(centroid);
    return SOFTSIM_OK;
}

/* The distinct control nodes of each leaf. */
static softsim_status list_leaf_nodes(ss_surface *surface)
{
    int32_t *seen = ss_memory_get((size_t)surface->node_count, sizeof(int32_t));
    if (seen == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    int32_t count = 0;
    for (int pass = 0; pass < 2; ++pass) {
        count = 0;
        for (int32_t leaf = 0; leaf < surface->leaf_count; ++leaf) {
            const int32_t mark = 1 + leaf + pass * surface->leaf_count;
            const int32_t first = ss_leaf_first_triangle(surface, leaf);
            const int32_t end = ss_leaf_first_triangle(surface, leaf + 1);
            for (int32_t c = surface->control_first[first]; c < surface->control_first[end]; ++c) {
                const int32_t node = surface->control[c];
                if (seen[node] != mark) {
                    seen[node] = mark;
                    if (pass == 1) {
                        surface->leaf_node[count] = node;
                    }
                    count++;
                }
            }
            surface->leaf_node_first[leaf + 1] = count;
        }
        if (pass == 0) {
            surface->leaf_node = ss_memory_get((size_t)count, sizeof(int32_t));
            if (surface->leaf_node == NULL) {
                break;
            }
        }
    }
    ss_memory_free(seen);
    return surface->leaf_node != NULL ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* Bounds how far any node is from where the boxes were fitted; NaN when one is or was not finite.
 * Four chains hide the latency of the maximum. */
static double moved_since_fit(const ss_surface *surface, const ss_real *u)
{
    const int64_t count = surface->node_count;
    ss_wide most[4] = {{0}, {0}, {0}, {0}};
    ss_wide none[4] = {{0}, {0}, {0}, {0}}; /* stay 0 unless something is not finite */
    for (int64_t i = 0; i < count; i += 4) {
        for (int c = 0; c < 4; ++c) {
            const int64_t at = 4 * (i + c < count ? i + c : count - 1);
            const ss_wide move =
                *(const ss_wide_loose *)(u + at) - *(const ss_wide_loose *)(surface->fitted_u + at);
            const ss_wide square = move * move;
            ss_wide_raise(&most[c], &square);
            none[c] += square * 0;
        }
    }
    for (int c = 1; c < 4; ++c) {
        ss_wide_raise(&most[0], &most[c]);
        none[0] += none[c];
    }
    const ss_wide sum = most[0] + none[0];
    return sqrt((double)(sum[0] + sum[1] + sum[2]));
}

static void fit_leaf(const ss_surface *surface, const ss_real *u, int32_t leaf, ss_box *out)
{
    const ss_real far = (ss_real)FLT_MAX;
    const ss_box empty = {{far, far, far, far}, {-far, -far, -far, -far}};
    const int32_t end = surface->leaf_node_first[leaf + 1];
    ss_box box[2] = {empty, empty};
    for (int32_t i = surface->leaf_node_first[leaf]; i < end; i += 2) {
        for (int c = 0; c < 2; ++c) {
            const int32_t node = surface->leaf_node[i + c < end ? i + c : i];
            const ss_wide x = *(const ss_wide_loose *)(surface->rest + 4 * (int64_t)node) +
                              *(const ss_wide_loose *)(u + 4 * (int64_t)node);
            ss_wide_lower(&box[c].low, &x);
            ss_wide_raise(&box[c].high, &x);
        }
    }
    ss_wide_lower(&box[0].low, &box[1].low);
    ss_wide_raise(&box[0].high, &box[1].high);
    *out = box[0];
}

static void fit_boxes(ss_surface *surface, const ss_real *u)
{
    const int32_t inner = surface->leaf_count - 1;
    for (int32_t leaf = 0; leaf < surface->leaf_count; ++leaf) {
        fit_leaf(surface, u, leaf, &surface->box[inner + leaf]);
    }
    for (int32_t i = inner - 1; i >= 0; --i) {
        ss_box *box = &surface->box[i];
        *box = surface->box[2 * i + 1];
        ss_wide_lower(&box->low, &surface->box[2 * i + 2].low);
        ss_wide_raise(&box->high, &surface->box[2 * i + 2].high);
    }
}

void ss_surface_refit(ss_surface *surface, const ss_real *u)
{
    if (surface->fit > 0) {
        surface->moved = moved_since_fit(surface, u);
        if (surface->moved <= stale_motion * surface->mean_edge) {
            return;
        }
    }
    fit_boxes(surface, u);
    memcpy(surface->fitted_u, u, 4 * sizeof(ss_real) * (size_t)surface->node_count);
    surface->fit++;
    surface->fit_moved = surface->moved;
    surface->moved = 0.0;
}

/* ---- create ---- */

static softsim_status check_mesh(const ss_mesh *mesh, softsim_error *error)
{
    if (mesh->triangle_count < 1 || mesh->triangle_count > 20000000) {
        softsim_error_add(error, SOFTSIM_ERROR_MESH,
                          "a contact surface needs 1 to 20000000 triangles, not %d",
                          mesh->triangle_count);
        return SOFTSIM_ERROR_MESH;
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *v = mesh->triangle[t];
        bool is_good = v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
        for (int k = 0; k < 3; ++k) {
            is_good = is_good && v[k] >= 0 && v[k] < mesh->node_count &&
                      ss_is_finite(mesh->position[v[k]], 3);
        }
        if (!is_good) {
            softsim_error_add(error, SOFTSIM_ERROR_MESH,
                              "triangle %d has a bad, repeated or non-finite node: repair the mesh",
                              t);
            return SOFTSIM_ERROR_MESH;
        }
    }
    return SOFTSIM_OK;
}

static double mean_edge(const ss_edges *edges, const ss_mesh *mesh)
{
    double sum = 0.0;
    int64_t count = 0;
    for (int32_t half = 0; half < 3 * mesh->triangle_count; ++half) {
        if (edges->twin[half] < half) { /* each edge once */
            double edge[3];
            ss_sub3(edge, mesh->position[mesh->triangle[half / 3][half % 3]],
                    mesh->position[mesh->triangle[half / 3][(half + 1) % 3]]);
            sum += ss_norm3(edge);
            count++;
        }
    }
    return sum / (double)count;
}

static bool is_closed(const ss_edges *edges)
{
    for (int32_t half = 0; half < 3 * edges->triangle_count; ++half) {
        if (edges->twin[half] < 0) {
            return false;
        }
    }
    return true;
}

/* The number m of parts, or an error where the samples would be too sparse for the tool. */
static softsim_status choose_parts(double radius, double edge, int *inout_parts,
                                   softsim_error *error)
{
    const bool has_tool = isfinite(radius) && radius > 0.0;
    if (*inout_parts == SS_SURFACE_CENTROIDS) {
        return SOFTSIM_OK;
    }
    if (has_tool && radius < least_radius_per_edge * edge) {
        softsim_error_add(
            error, SOFTSIM_ERROR_SCENE,
            "the smallest of contact.tools has a radius of %.4g mm, below %.1f of the "
            "mesh's mean edge %.4g mm: use a mesh with edges of at most %.4g mm or a tool of at "
            "least %.4g mm",
            1e3 * radius, least_radius_per_edge, 1e3 * edge, 1e3 * radius / least_radius_per_edge,
            1e3 * least_radius_per_edge * edge);
        return SOFTSIM_ERROR_SCENE;
    }
    if (*inout_parts == 0) {
        *inout_parts = !has_tool ? 2 : radius < 0.5 * edge ? 3 : radius < 3.0 * edge ? 2 : 1;
    } else if (has_tool && edge / (4.0 * *inout_parts) > radius / 3.0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "contact samples %.4g mm apart are too sparse for a tool of radius "
                          "%.4g mm: use more parts than %d",
                          1e3 * edge / (4.0 * *inout_parts), 1e3 * radius, *inout_parts);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    return SOFTSIM_OK;
}

static bool allocate(ss_surface *surface, const ss_mesh *mesh)
{
    const size_t triangle_count = (size_t)mesh->triangle_count;
    const size_t node_count = (size_t)mesh->node_count;
    surface->node_count = mesh->node_count;
    surface->triangle_count = mesh->triangle_count;
    surface->leaf_count = 1;
    while ((int64_t)surface->leaf_count * SS_TREE_LEAF < mesh->triangle_count) {
        surface->leaf_count *= 2;
    }
    const size_t leaf_count = (size_t)surface->leaf_count;
    surface->rest = ss_memory_get(node_count, 4 * sizeof(ss_real));
    surface->control_first = ss_memory_get(triangle_count + 1, sizeof(int32_t));
    surface->patch_of = ss_memory_get(triangle_count, sizeof(int32_t));
    surface->area = ss_memory_get(triangle_count, sizeof(ss_real));
    surface->fan = ss_memory_get(triangle_count, sizeof *surface->fan);
    surface->leaf_node_first = ss_memory_get(leaf_count + 1, sizeof(int32_t));
    surface->box = ss_memory_get(2 * leaf_count, sizeof(ss_box));
    surface->fitted_u = ss_memory_get(node_count, 4 * sizeof(ss_real));
    return surface->rest != NULL && surface->control_first != NULL && surface->patch_of != NULL &&
           surface->area != NULL && surface->fan != NULL && surface->leaf_node_first != NULL &&
           surface->box != NULL && surface->fitted_u != NULL;
}

/* Rest positions about the middle of the surface's box. */
static void set_rest(ss_surface *surface, const ss_mesh *mesh)
{
    double low[3] = {DBL_MAX, DBL_MAX, DBL_MAX};
    double high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    for (int32_t t = 0; t < 3 * mesh->triangle_count; ++t) {
        const double *x = mesh->position[mesh->triangle[t / 3][t % 3]];
        for (int k = 0; k < 3; ++k) {
            low[k] = fmin(low[k], x[k]);
            high[k] = fmax(high[k], x[k]);
        }
    }
    double diagonal[3];
    ss_sub3(diagonal, high, low);
    ss_madd3(surface->centre, low, 0.5, diagonal);
    surface->size = 0.5 * ss_norm3(diagonal);
    for (int64_t i = 0; i < mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            surface->rest[4 * i + k] = (ss_real)(mesh->position[i][k] - surface->centre[k]);
        }
    }
}

static double triangle_area(const ss_mesh *mesh, int32_t t)
{
    const int32_t *v = mesh->triangle[t];
    double cross[3];
    ss_normal3(cross, mesh->position[v[0]], mesh->position[v[1]], mesh->position[v[2]]);
    return 0.5 * ss_norm3(cross);
}

static softsim_status build(ss_surface *surface, const ss_mesh *mesh, const ss_edges *edges,
                            int parts)
{
    int32_t *order = ss_memory_get((size_t)mesh->triangle_count, sizeof(int32_t));
    softsim_status status =
        order != NULL && allocate(surface, mesh) ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    if (status == SOFTSIM_OK) {
        set_grid(&surface->grid, parts);
        set_rest(surface, mesh);
        status = order_triangles(surface, mesh, order);
    }
    if (status == SOFTSIM_OK) {
        for (int32_t t = 0; t < mesh->triangle_count; ++t) {
            surface->area[t] = (ss_real)triangle_area(mesh, order[t]);
        }
        status = ss_subdivide(edges, order, parts == SS_SURFACE_CENTROIDS, surface);
    }
    if (status == SOFTSIM_OK) {
        status = list_leaf_nodes(surface);
    }
    if (status == SOFTSIM_OK) {
        status = ss_surface_curve(surface, mesh, edges);
    }
    ss_memory_free(order);
    return status;
}

softsim_status ss_surface_create(const ss_mesh *mesh, double smallest_tool_radius, int parts,
                                 ss_surface **out_surface, softsim_error *error)
{
    *out_surface = NULL;
    if (parts < SS_SURFACE_CENTROIDS || parts > SS_MAX_PARTS) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "contact parts must be 0 to %d, not %d",
                          SS_MAX_PARTS, parts);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    softsim_status status = check_mesh(mesh, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_edges edges;
    status = ss_edges_init(&edges, mesh, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const double edge = mean_edge(&edges, mesh);
    status = choose_parts(smallest_tool_radius, edge, &parts, error);
    if (status == SOFTSIM_OK) {
        ss_surface *surface = ss_memory_get(1, sizeof(ss_surface));
        status = SOFTSIM_ERROR_MEMORY;
        if (surface != NULL) {
            surface->mean_edge = edge;
            surface->is_closed = is_closed(&edges);
            status = build(surface, mesh, &edges, parts);
        }
        if (status == SOFTSIM_OK) {
            *out_surface = surface;
        } else {
            ss_surface_destroy(&surface);
            softsim_error_add(error, status, "no memory for the contact surface");
        }
    }
    ss_edges_fini(&edges);
    return status;
}

void ss_surface_destroy(ss_surface **surface)
{
    if (surface == NULL || *surface == NULL) {
        return;
    }
    void *memory[] = {
        (*surface)->rest,          (*surface)->control_first, (*surface)->control,
        (*surface)->patch_of,      (*surface)->area,          (*surface)->patch,
        (*surface)->coefficient,   (*surface)->fan,           (*surface)->fan_normal,
        (*surface)->fan_curvature, (*surface)->leaf_node,     (*surface)->leaf_node_first,
        (*surface)->box,           (*surface)->fitted_u};
    for (size_t i = 0; i < sizeof memory / sizeof memory[0]; ++i) {
        ss_memory_free(memory[i]);
    }
    ss_memory_free(*surface);
    *surface = NULL;
}

int64_t ss_surface_sample_count(const ss_surface *surface)
{
    return (int64_t)surface->triangle_count * surface->grid.facet_count * surface->grid.part_count;
}

double ss_surface_mean_edge(const ss_surface *surface)
{
    return surface->mean_edge;
}

/* From the place of a triangle's corner on the sampled surface to its node, along its normal. */
static double stands_out(const ss_surface *surface, int32_t t, int corner)
{
    const ss_patch *patch = &surface->patch[surface->patch_of[t]];
    const ss_real *row = surface->coefficient + (int64_t)patch->first * SS_GRID_ROW;
    const int32_t *control = surface->control + surface->control_first[t];
    const ss_real *own = surface->rest + 4 * (int64_t)control[corner];
    const ss_real *normal = surface->fan_normal[surface->fan[t][corner]];
    const int p = surface->grid.corner[corner];
    double out = 0.0;
    for (int32_t i = 0; i < patch->control_count; ++i, row += SS_GRID_ROW) {
        const ss_real *x = surface->rest + 4 * (int64_t)control[i];
        for (int c = 0; c < 3; ++c) {
            out += (double)row[p] * ((double)own[c] - (double)x[c]) * (double)normal[c];
        }
    }
    return out;
}

double ss_surface_rounding(const ss_surface *surface, double out_at[3])
{
    double most = 0.0;
    ss_set3(out_at, 0.0, 0.0, 0.0);
    for (int32_t t = 0; t < surface->triangle_count; ++t) {
        for (int corner = 0; corner < 3; ++corner) {
            const double out = stands_out(surface, t, corner);
            if (out > most) {
                const int32_t node = surface->control[surface->control_first[t] + corner];
                most = out;
                for (int c = 0; c < 3; ++c) {
                    out_at[c] = surface->centre[c] + (double)surface->rest[4 * (int64_t)node + c];
                }
            }
        }
    }
    return most;
}
