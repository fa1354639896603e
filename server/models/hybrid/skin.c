/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hybrid/hybrid.h"
/*
 * The surface that is seen and touched: its nodes ride on the layer.
 *
 * A skin node where all sleeps follows the core by one row, T. Where particles are awake it follows
 * the sixteen nearest ones, S; of these, those that are tied are put in terms of nodes at once, so
 * that a row over the body's nodes results. On the way from one to the other it is (1 - theta) T +
 * theta S with a slow theta: linear at every moment, so that forces on it go back by the transpose
 * and momentum is kept, and without a jump. Contact with the particles themselves was rejected:
 * the tool would feel the lattice.
 *
 * Sleeping skin far from every tool is laid in turns, an eighth of it an outer step: nothing but
 * the contact's search tree reads it between two looks of the display, and that search is generous.
 * What is near a tool is listed as seldom, or when a tool has moved by half an edge.
 */
#include <math.h>
#include <string.h>

#include "models/common/wide.h"
#include "rt/vec.h"

enum { LAY_BATCHES = 8 };

/* ---- rows ---- */

static ss_quad sum_row(int32_t count, const int32_t *node, const ss_real *weight, const ss_real *u)
{
    ss_quad sum = ss_quad_all(0);
    for (int32_t k = 0; k < count; ++k) {
        sum = ss_quad_fma(ss_quad_all(weight[k]), ss_quad_load(u + 4 * (ptrdiff_t)node[k]), sum);
    }
    return sum;
}

/* All the way: its tie to the core says nothing any more. */
static bool is_riding(const ss_hybrid_ride *ride)
{
    return ride->count > 0 && !(ride->theta < 1);
}

static ss_quad place_of(const ss_hybrid *hybrid, int32_t s, const ss_real *u)
{
    const ss_layer *layer = hybrid->layer;
    const ss_hybrid_ride *ride = &hybrid->ride[s];
    const int32_t first = layer->skin_tie_first[s];
    if (is_riding(ride)) {
        return sum_row(ride->count, ride->node, ride->weight, u);
    }
    const ss_quad tied = sum_row(layer->skin_tie_first[s + 1] - first, layer->skin_tie_node + first,
                                 layer->skin_tie + first, u);
    if (ride->count == 0 || !(ride->theta > 0)) {
        return tied;
    }
    const ss_quad riding = sum_row(ride->count, ride->node, ride->weight, u);
    return ss_quad_fma(ss_quad_all(ride->theta), ss_quad_sub(riding, tied), tied);
}

void ss_hybrid_show(const ss_hybrid *hybrid, const ss_real *u, ss_real *out)
{
    memcpy(out, u, 4 * (size_t)hybrid->mesh->node_count * sizeof *out);
    for (int32_t s = 0; s < hybrid->layer->skin_count; ++s) {
        ss_quad_store(out + 4 * (ptrdiff_t)hybrid->layer->skin_node[s], place_of(hybrid, s, u));
    }
}

/* Has no tool come, left or moved by half an edge since the last list? */
static bool is_list_good(const ss_hybrid *hybrid)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_model_tool *tool = &hybrid->tool[k];
        if (tool->is_present != hybrid->was_listed[k]) {
            return false;
        }
        if (tool->is_present) {
            double moved[3];
            ss_sub3(moved, tool->to.position, hybrid->listed[k]);
            if (!(ss_norm3(moved) <= 0.5 * hybrid->skin_edge)) {
                return false;
            }
        }
    }
    return true;
}

void ss_hybrid_list_skin(ss_hybrid *hybrid)
{
    const ss_layer *layer = hybrid->layer;
    hybrid->is_batch_due = true;
    if (++hybrid->list_age < LAY_BATCHES && is_list_good(hybrid)) {
        return;
    }
    hybrid->list_age = hybrid->close_count = hybrid->around_count = 0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        hybrid->was_listed[k] = hybrid->tool[k].is_present;
        ss_copy3(hybrid->listed[k], hybrid->tool[k].to.position);
    }
    for (int32_t s = 0; s < layer->skin_count; ++s) {
        const int32_t node = layer->skin_node[s];
        const ss_real *u = hybrid->laid + 4 * (ptrdiff_t)node;
        bool is_close = false;
        bool is_around = false;
        for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
            if (hybrid->tool[k].is_present) {
                double d[3];
                for (int a = 0; a < 3; ++a) {
                    d[a] = hybrid->mesh->position[node][a] + (double)u[a] - hybrid->listed[k][a];
                }
                const double square = ss_dot3(d, d);
                /* Two long edges, where those are more than the three that are reckoned with. */
                const double close = hybrid->close_reach[k] +
                                     fmax(2.0 * hybrid->span[s] - 3.0 * hybrid->skin_edge, 0.0);
                const double around = hybrid->around_reach[k];
                is_close = is_close || square < close * close;
                is_around = is_around || square < around * around;
            }
        }
        if (is_close) {
            hybrid->close[hybrid->close_count++] = s;
        }
        if (is_around) {
            hybrid->around[hybrid->around_count++] = s;
        }
    }
}

/* Skin node s into the body's array, and into `laid` unless that is NULL. */
static void lay_node(const ss_hybrid *hybrid, int32_t s, const ss_real *u, ss_real *skin_u,
                     ss_real *laid)
{
    const ptrdiff_t at = 4 * (ptrdiff_t)hybrid->layer->skin_node[s];
    const ss_quad place = place_of(hybrid, s, u);
    ss_quad_store(skin_u + at, place);
    if (laid != NULL) {
        ss_quad_store(laid + at, place);
    }
}

/* The body lays displacements, and motions that its solver tries, in the same array: what is known
 * of the sleeping skin is kept apart. Motions are wanted under the tools alone. */
void ss_hybrid_lay(void *owner, const ss_real *u, ss_real *skin_u)
{
    ss_hybrid *hybrid = owner;
    const bool is_motion = u != hybrid->u;
    ss_real *laid = is_motion ? NULL : hybrid->laid;
    if (!is_motion && hybrid->is_skin_old) {
        memcpy(skin_u, laid, 4 * (size_t)hybrid->mesh->node_count * sizeof *skin_u);
    }
    hybrid->is_skin_old = is_motion;
    for (int32_t k = 0; k < hybrid->core_count; ++k) {
        const ptrdiff_t at = 4 * (ptrdiff_t)hybrid->core_node[k];
        ss_quad_store(skin_u + at, ss_quad_load(u + at));
    }
    for (int32_t k = 0; k < hybrid->riding_count; ++k) {
        lay_node(hybrid, hybrid->riding[k], u, skin_u, laid);
    }
    for (int32_t k = 0; k < hybrid->close_count; ++k) {
        if (hybrid->riding_at[hybrid->close[k]] < 0) {
            lay_node(hybrid, hybrid->close[k], u, skin_u, laid);
        }
    }
    if (!is_motion && hybrid->is_batch_due) {
        hybrid->is_batch_due = false;
        hybrid->lay_batch = (hybrid->lay_batch + 1) % LAY_BATCHES;
        for (int32_t s = hybrid->lay_batch; s < hybrid->layer->skin_count; s += LAY_BATCHES) {
            lay_node(hybrid, s, u, skin_u, laid);
        }
    }
}

static void give_row(int32_t count, const int32_t *node, const ss_real *weight, ss_quad f,
                     ss_real *force)
{
    for (int32_t k = 0; k < count; ++k) {
        ss_real *at = force + 4 * (ptrdiff_t)node[k];
        ss_quad_store(at, ss_quad_fma(ss_quad_all(weight[k]), f, ss_quad_load(at)));
    }
}

void ss_hybrid_carry(void *owner, int32_t count, const int32_t *node, const ss_real *skin_force,
                     ss_real *force)
{
    const ss_hybrid *hybrid = owner;
    const ss_layer *layer = hybrid->layer;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t s = layer->skin_of[node[i]];
        const ss_real *push = skin_force + 4 * (ptrdiff_t)node[i];
        if (push[0] == 0 && push[1] == 0 && push[2] == 0) {
            continue;
        }
        const ss_quad f = ss_quad_load(push);
        if (s < 0) {
            ss_real *at = force + 4 * (ptrdiff_t)node[i];
            ss_quad_store(at, ss_quad_add(ss_quad_load(at), f));
            continue;
        }
        const ss_hybrid_ride *ride = &hybrid->ride[s];
        const ss_real theta = ride->count > 0 ? ride->theta : 0;
        const int32_t first = layer->skin_tie_first[s];
        if (!is_riding(ride)) {
            give_row(layer->skin_tie_first[s + 1] - first, layer->skin_tie_node + first,
                     layer->skin_tie + first, ss_quad_mul(ss_quad_all(1 - theta), f), force);
        }
        give_row(ride->count, ride->node, ride->weight, ss_quad_mul(ss_quad_all(theta), f), force);
    }
}

/* A row w of S bounds S^T k S by |w_i| k sum |w|. */
static void bound_row(int32_t count, const int32_t *node, const ss_real *weight, double stiffness,
                      double *diagonal)
{
    double sum = 0.0;
    for (int32_t k = 0; k < count; ++k) {
        sum += fabs((double)weight[k]);
    }
    for (int32_t k = 0; k < count; ++k) {
        diagonal[node[k]] += fabs((double)weight[k]) * sum * stiffness;
    }
}

void ss_hybrid_carry_diagonal(void *owner, int32_t count, const int32_t *node, const double *skin,
                              double *diagonal)
{
    const ss_hybrid *hybrid = owner;
    const ss_layer *layer = hybrid->layer;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t s = layer->skin_of[node[i]];
        const double stiffness = skin[node[i]];
        if (s < 0) {
            diagonal[node[i]] += stiffness;
            continue;
        }
        const ss_hybrid_ride *ride = &hybrid->ride[s];
        const double theta = ride->count > 0 ? (double)ride->theta : 0.0;
        const int32_t first = layer->skin_tie_first[s];
        bound_row(layer->skin_tie_first[s + 1] - first, layer->skin_tie_node + first,
                  layer->skin_tie + first, (1.0 - theta) * stiffness, diagonal);
        bound_row(ride->count, ride->node, ride->weight, theta * stiffness, diagonal);
    }
}

/* ---- the contact's stiffness against the masses ---- */
/* With D = diag(skin) and A = |S| M^-1 |S|^T D, not negative, the largest eigenvalue of M^-1 S^T D
 * S is at most that of A, and that at most max_s (A x)_s / x_s for any x > 0 (Collatz). x = 1 gives
 * row sums; x = A 1 less, for the price of another turn. By columns, max_i 1/m_i sum_s |S_si| k_s
 * sum_j |S_sj|, it was 1.5 to 1.8 times as much: a row's squares say less than its largest weight.
 */

enum { SWINGS = 2 };

typedef struct skin_row {
    int32_t count;
    const int32_t *node;
    const ss_real *weight;
    double share;
} skin_row;

/* The rows over nodes that skin node `node` follows. */
static int rows_of(const ss_hybrid *hybrid, const int32_t *node, skin_row out[2])
{
    static const ss_real whole = 1;
    const ss_layer *layer = hybrid->layer;
    const int32_t s = layer->skin_of[*node];
    if (s < 0) {
        out[0] = (skin_row){1, node, &whole, 1.0};
        return 1;
    }
    const ss_hybrid_ride *ride = &hybrid->ride[s];
    const double theta = ride->count > 0 ? (double)ride->theta : 0.0;
    const int32_t first = layer->skin_tie_first[s];
    const skin_row riding = {ride->count, ride->node, ride->weight, theta};
    if (is_riding(ride)) {
        out[0] = riding;
        return 1;
    }
    out[0] = (skin_row){layer->skin_tie_first[s + 1] - first, layer->skin_tie_node + first,
                        layer->skin_tie + first, 1.0 - theta};
    out[1] = riding;
    return theta > 0.0 ? 2 : 1;
}

double ss_hybrid_carry_rate2(void *owner, int32_t count, const int32_t *node, const double *skin,
                             const ss_real *mobility)
{
    const ss_hybrid *hybrid = owner;
    double *load = hybrid->load;
    double *swing = hybrid->swing;
    double largest = 0.0;
    skin_row row[2];
    for (int32_t i = 0; i < count; ++i) {
        swing[i] = 1.0;
    }
    for (int turn = 0; turn < SWINGS; ++turn) {
        for (int32_t i = 0; i < count; ++i) {
            for (int r = rows_of(hybrid, node + i, row) - 1; r >= 0; --r) {
                const double push = row[r].share * skin[node[i]] * swing[i];
                for (int32_t k = 0; k < row[r].count; ++k) {
                    load[row[r].node[k]] += fabs((double)row[r].weight[k]) * push;
                }
            }
        }
        largest = 0.0;
        for (int32_t i = 0; i < count; ++i) {
            double sum = 0.0;
            for (int r = rows_of(hybrid, node + i, row) - 1; r >= 0; --r) {
                for (int32_t k = 0; k < row[r].count; ++k) {
                    const ptrdiff_t n = row[r].node[k];
                    const ss_real *light = mobility + 4 * n;
                    const ss_real most = light[0] > light[1] ? light[0] : light[1];
                    sum += row[r].share * fabs((double)row[r].weight[k]) * load[n] *
                           (double)(most > light[2] ? most : light[2]);
                }
            }
            largest = fmax(largest, swing[i] > 0.0 ? sum / swing[i] : 0.0);
            swing[i] = sum;
        }
        for (int32_t i = 0; i < count; ++i) {
            for (int r = rows_of(hybrid, node + i, row) - 1; r >= 0; --r) {
                for (int32_t k = 0; k < row[r].count; ++k) {
                    load[row[r].node[k]] = 0.0;
                }
            }
        }
    }
    return largest;
}

/* ---- following the particles ---- */

/* Adds to entry `node` of a row. */
static void add_entry(ss_hybrid *hybrid, ss_hybrid_ride *ride, int32_t node, ss_real weight)
{
    if (hybrid->mark[node] < 0) {
        hybrid->mark[node] = ride->count;
        ride->node[ride->count] = node;
        ride->weight[ride->count++] = 0;
    }
    ride->weight[hybrid->mark[node]] += weight;
}

/* The row of skin node s from its particles as they now are. */
static void make_row(ss_hybrid *hybrid, int32_t s)
{
    const ss_layer *layer = hybrid->layer;
    ss_hybrid_ride *ride = &hybrid->ride[s];
    ride->count = 0;
    ride->is_old = false;
    for (int32_t k = layer->skin_first[s]; k < layer->skin_first[s + 1]; ++k) {
        const int32_t p = layer->skin_particle[k];
        if (hybrid->node_of[p] >= 0) {
            add_entry(hybrid, ride, hybrid->node_of[p], layer->skin[k]);
            continue;
        }
        for (int32_t t = layer->tie_first[p]; t < layer->tie_first[p + 1]; ++t) {
            add_entry(hybrid, ride, layer->tie_node[t], layer->skin[k] * layer->tie[t]);
        }
    }
    for (int32_t k = 0; k < ride->count; ++k) {
        hybrid->mark[ride->node[k]] = -1;
    }
}

void ss_hybrid_tell_skin(ss_hybrid *hybrid, int32_t p, int change)
{
    for (int32_t k = hybrid->rider_first[p]; k < hybrid->rider_first[p + 1]; ++k) {
        const int32_t s = hybrid->rider[k];
        hybrid->ride[s].wanted += change;
        hybrid->is_skin_fading = true;
        if (hybrid->riding_at[s] < 0 && change > 0) {
            hybrid->riding_at[s] = hybrid->riding_count;
            hybrid->riding[hybrid->riding_count++] = s;
        }
        hybrid->ride[s].is_old = true;
    }
}

bool ss_hybrid_fade_skin(ss_hybrid *hybrid, ss_real step)
{
    bool has_changed = false;
    hybrid->is_skin_fading = false;
    for (int32_t k = hybrid->riding_count - 1; k >= 0; --k) {
        const int32_t s = hybrid->riding[k];
        ss_hybrid_ride *ride = &hybrid->ride[s];
        const ss_real before = ride->theta;
        if (ride->is_old) {
            make_row(hybrid, s);
        }
        if (ride->wanted > 0) {
            ride->theta = before + step < 1 ? before + step : 1;
            hybrid->is_skin_fading = hybrid->is_skin_fading || ride->theta < 1;
        } else if (before > step) {
            ride->theta -= step;
            hybrid->is_skin_fading = true;
        } else {
            const int32_t last = hybrid->riding[--hybrid->riding_count];
            hybrid->riding[k] = last;
            hybrid->riding_at[last] = k;
            hybrid->riding_at[s] = -1;
            ride->theta = 0;
            ride->count = 0;
        }
        has_changed = has_changed || ride->theta != before;
    }
    return has_changed;
}
