/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/fem_quadratic/quadratic.h"
/*
 * The surface that is touched: curved faces, each in sixteen flat parts.
 *
 * Contact at nodes pushes corners and edges alike, though a quadratic face under an even pressure
 * has no force on its corners: the force of a ball that slides over coarse faces then ranges by 15
 * to 23 %. So each face is sampled at the middles of sixteen parts. The parts' corners are points
 * of the face, at quarters of its edges; they ride on its six nodes by the shape functions
 *
 *   x = sum_k l_k (2 l_k - 1) x_k + sum_{j < k} 4 l_j l_k x_jk,
 *
 * and forces go back to the nodes by the transpose. The contact itself is the one of all models, on
 * this skin (ss_body_skin).
 *
 * Skin far from every tool is laid once an outer step: nothing but the contact's search tree reads
 * it before the next.
 */
#include <math.h>
#include <string.h>

#include "models/common/wide.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { GRID = 4, POINTS = 15, PARTS = 16, SWINGS = 4 };

/* The six weights at barycentric (i, j, k)/4; edges 01, 12, 20. */
static void weights_at(int i, int j, int k, double out[6])
{
    const double l[3] = {(double)i / GRID, (double)j / GRID, (double)k / GRID};
    for (int a = 0; a < 3; ++a) {
        out[a] = l[a] * (2.0 * l[a] - 1.0);
        out[3 + a] = 4.0 * l[a] * l[(a + 1) % 3];
    }
}

/* ---- life ---- */

typedef struct builder {
    ss_quadratic_skin *skin;
    const ss_quadratic_raised *raised;
    int32_t *corner;  /* the skin's node of a raised one, -1 */
    int32_t *quarter; /* of an edge's node: the two beside it, from its lower end; -1 */
} builder;

static int32_t add_point(builder *b, int count, const int32_t *node, const double *weight)
{
    ss_quadratic_skin *skin = b->skin;
    const int32_t s = skin->mesh.node_count++;
    int32_t at = skin->first[s];
    ss_set3(skin->mesh.position[s], 0.0, 0.0, 0.0);
    for (int k = 0; k < count; ++k) {
        if (weight[k] != 0.0) {
            skin->node[at] = node[k];
            skin->weight[at++] = (ss_real)weight[k];
            for (int i = 0; i < 3; ++i) {
                skin->mesh.position[s][i] += weight[k] * b->raised->mesh.position[node[k]][i];
            }
        }
    }
    skin->first[s + 1] = at;
    return s;
}

/* The skin's node at (i, j, k)/4 of a face with these six nodes. */
static int32_t point_of(builder *b, const int32_t node[6], int i, int j, int k)
{
    const int l[3] = {i, j, k};
    double weight[6];
    weights_at(i, j, k, weight);
    int32_t *place = NULL;
    for (int a = 0; a < 3; ++a) {
        const int c = (a + 1) % 3;
        if (l[a] == GRID) {
            place = &b->corner[node[a]];
        } else if (l[a] == 2 && l[c] == 2) {
            place = &b->corner[node[3 + a]];
        } else if (l[a] + l[c] == GRID && l[a] > 0 && l[c] > 0) {
            const bool is_low_near = (node[a] < node[c]) == (l[a] == 3);
            place = &b->quarter[2 * (ptrdiff_t)node[3 + a] + (is_low_near ? 0 : 1)];
        }
    }
    if (place == NULL) {
        return add_point(b, 6, node, weight);
    }
    if (*place < 0) {
        *place = add_point(b, 6, node, weight);
    }
    return *place;
}

static void add_face(builder *b, int32_t face)
{
    const int32_t(*four)[3] = (const int32_t(*)[3])b->raised->mesh.triangle + 4 * (ptrdiff_t)face;
    const int32_t node[6] = {four[0][0], four[1][0], four[2][0],
                             four[3][0], four[3][1], four[3][2]};
    int32_t at[GRID + 1][GRID + 1];
    int32_t(*out)[3] = b->skin->mesh.triangle + PARTS * (ptrdiff_t)face;
    for (int j = 0; j <= GRID; ++j) {
        for (int k = 0; j + k <= GRID; ++k) {
            at[j][k] = point_of(b, node, GRID - j - k, j, k);
        }
    }
    for (int j = 0; j < GRID; ++j) {
        for (int k = 0; j + k < GRID; ++k) {
            const int32_t up[3] = {at[j][k], at[j + 1][k], at[j][k + 1]};
            memcpy(*out++, up, sizeof up);
            if (j + k < GRID - 1) {
                const int32_t down[3] = {at[j + 1][k], at[j + 1][k + 1], at[j][k + 1]};
                memcpy(*out++, down, sizeof down);
            }
        }
    }
}

static double mean_sigma(const ss_quadratic_raised *raised, const double *mass)
{
    double sum = 0.0, total = 0.0;
    double *area = ss_memory_get((size_t)raised->mesh.node_count, sizeof *area);
    if (!area) {
        return -1.0;
    }
    ss_mesh_node_areas(&raised->mesh, area);
    for (int32_t i = 0; i < raised->mesh.node_count; ++i) {
        if (area[i] > 0.0 && (raised->plan.fixed[i] & 7) != 7) {
            sum += mass[i];
            total += area[i];
        }
    }
    ss_memory_free(area);
    return total > 0.0 ? sum / total : 0.0;
}

softsim_status ss_quadratic_skin_create(const ss_quadratic_raised *raised, const double *mass,
                                        ss_arena *arena, ss_quadratic_skin *skin)
{
    const size_t faces = (size_t)raised->mesh.triangle_count / 4;
    const size_t nodes = (size_t)raised->mesh.node_count, most = POINTS * faces;
    builder b = {.skin = skin,
                 .raised = raised,
                 .corner = ss_memory_get(nodes, sizeof *b.corner),
                 .quarter = ss_memory_get(2 * nodes, sizeof *b.quarter)};
    *skin = (ss_quadratic_skin){
        .raised = raised,
        .mesh = {.is_closed = raised->mesh.is_closed,
                 .position = ss_arena_get(arena, most, sizeof(double[3])),
                 .triangle = ss_arena_get(arena, PARTS * faces, sizeof(int32_t[3])),
                 .triangle_count = (int32_t)(PARTS * faces)},
        .first = ss_arena_get(arena, most + 1, sizeof(int32_t)),
        .node = ss_arena_get(arena, 6 * most, sizeof(int32_t)),
        .weight = ss_arena_get(arena, 6 * most, sizeof(ss_real)),
        .close = ss_arena_get(arena, most, sizeof(int32_t)),
        .load = ss_arena_get(arena, nodes, sizeof(double)),
        .swing = ss_arena_get(arena, most, sizeof(double)),
        .sigma = mean_sigma(raised, mass)};
    const bool is_good = b.corner && b.quarter && ss_arena_status(arena) == SOFTSIM_OK;
    if (is_good) {
        memset(b.corner, 0xff, nodes * sizeof *b.corner);
        memset(b.quarter, 0xff, 2 * nodes * sizeof *b.quarter);
        for (size_t f = 0; f < faces; ++f) {
            add_face(&b, (int32_t)f);
        }
        skin->edge = ss_body_mean_side(&skin->mesh);
        ss_quadratic_skin_list(skin, NULL, NULL);
    }
    ss_memory_free(b.corner);
    ss_memory_free(b.quarter);
    return is_good && skin->sigma >= 0.0 ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* ---- entry points of the body ---- */

static ss_quad laid(const ss_quadratic_skin *skin, int32_t s, const ss_real *u)
{
    ss_quad sum = ss_quad_all(0);
    for (int32_t k = skin->first[s]; k < skin->first[s + 1]; ++k) {
        sum = ss_quad_fma(ss_quad_all(skin->weight[k]),
                          ss_quad_load(u + 4 * (ptrdiff_t)skin->node[k]), sum);
    }
    return sum;
}

void ss_quadratic_skin_list(ss_quadratic_skin *skin, const ss_real *u,
                            const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    const double *middle[SOFTSIM_MAX_PROBES];
    double square[SOFTSIM_MAX_PROBES];
    int present = 0;
    for (int p = 0; tool && p < SOFTSIM_MAX_PROBES; ++p) {
        if (tool[p].is_present) {
            double way[3];
            ss_sub3(way, tool[p].to.position, tool[p].from.position);
            const double reach = skin->reach[p] + ss_norm3(way);
            middle[present] = tool[p].to.position;
            square[present++] = reach * reach;
        }
    }
    skin->is_all_due = true;
    skin->close_count = 0;
    for (int32_t s = 0; s < skin->mesh.node_count && (present > 0 || !tool); ++s) {
        bool is_close = !tool;
        const ss_quad way = tool ? laid(skin, s, u) : ss_quad_all(0);
        const double *rest = skin->mesh.position[s];
        for (int p = 0; p < present && !is_close; ++p) {
            const double d[3] = {rest[0] + (double)way[0] - middle[p][0],
                                 rest[1] + (double)way[1] - middle[p][1],
                                 rest[2] + (double)way[2] - middle[p][2]};
            is_close = ss_dot3(d, d) < square[p];
        }
        if (is_close) {
            skin->close[skin->close_count++] = s;
        }
    }
}

void ss_quadratic_skin_lay(void *owner, const ss_real *u, ss_real *skin_u)
{
    ss_quadratic_skin *skin = ((ss_quadratic *)owner)->skin;
    if (skin->is_all_due) {
        skin->is_all_due = false;
        for (int32_t s = 0; s < skin->mesh.node_count; ++s) {
            ss_quad_store(skin_u + 4 * (ptrdiff_t)s, laid(skin, s, u));
        }
        return;
    }
    for (int32_t k = 0; k < skin->close_count; ++k) {
        ss_quad_store(skin_u + 4 * (ptrdiff_t)skin->close[k], laid(skin, skin->close[k], u));
    }
}

void ss_quadratic_skin_carry(void *owner, int32_t count, const int32_t *node,
                             const ss_real *skin_force, ss_real *force)
{
    const ss_quadratic_skin *skin = ((const ss_quadratic *)owner)->skin;
    for (int32_t i = 0; i < count; ++i) {
        const ss_real *push = skin_force + 4 * (ptrdiff_t)node[i];
        if (push[0] == 0 && push[1] == 0 && push[2] == 0) {
            continue;
        }
        const ss_quad f = ss_quad_load(push);
        for (int32_t k = skin->first[node[i]]; k < skin->first[node[i] + 1]; ++k) {
            ss_real *at = force + 4 * (ptrdiff_t)skin->node[k];
            ss_quad_store(at, ss_quad_fma(ss_quad_all(skin->weight[k]), f, ss_quad_load(at)));
        }
    }
}

/* A row w of S bounds S^T k S by |w_i| k sum |w|. */
void ss_quadratic_skin_carry_diagonal(void *owner, int32_t count, const int32_t *node,
                                      const double *stiffness, double *diagonal)
{
    const ss_quadratic_skin *skin = ((const ss_quadratic *)owner)->skin;
    for (int32_t i = 0; i < count; ++i) {
        double sum = 0.0;
        for (int32_t k = skin->first[node[i]]; k < skin->first[node[i] + 1]; ++k) {
            sum += fabs((double)skin->weight[k]);
        }
        for (int32_t k = skin->first[node[i]]; k < skin->first[node[i] + 1]; ++k) {
            diagonal[skin->node[k]] += fabs((double)skin->weight[k]) * sum * stiffness[node[i]];
        }
    }
}

/* The eigenvalues of M^-1 S^T k S are those of A = S M^-1 S^T k on the skin; with |S| in place of S
 * they are at most max_i (A x)_i / x_i for any x > 0, sharper with each turn x := A x. */
double ss_quadratic_skin_rate2(void *owner, int32_t count, const int32_t *node,
                               const double *stiffness, const ss_real *mobility)
{
    const ss_quadratic_skin *skin = ((const ss_quadratic *)owner)->skin;
    double *load = skin->load, *swing = skin->swing, largest = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        swing[i] = 1.0;
    }
    for (int turn = 0; turn < SWINGS; ++turn) {
        for (int32_t i = 0; i < count; ++i) {
            for (int32_t k = skin->first[node[i]]; k < skin->first[node[i] + 1]; ++k) {
                load[skin->node[k]] +=
                    fabs((double)skin->weight[k]) * stiffness[node[i]] * swing[i];
            }
        }
        largest = 0.0;
        for (int32_t i = 0; i < count; ++i) {
            double sum = 0.0;
            for (int32_t k = skin->first[node[i]]; k < skin->first[node[i] + 1]; ++k) {
                const ss_real *light = mobility + 4 * (ptrdiff_t)skin->node[k];
                const double most =
                    fmax((double)light[0], fmax((double)light[1], (double)light[2]));
                sum += fabs((double)skin->weight[k]) * load[skin->node[k]] * most;
            }
            largest = fmax(largest, swing[i] > 0.0 ? sum / swing[i] : 0.0);
            swing[i] = sum;
        }
        for (int32_t i = 0; i < count; ++i) {
            for (int32_t k = skin->first[node[i]]; k < skin->first[node[i] + 1]; ++k) {
                load[skin->node[k]] = 0.0;
            }
        }
    }
    return largest;
}
