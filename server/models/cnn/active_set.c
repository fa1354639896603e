/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * The active set: a step costs the nodes that a load has in its reach, not the whole surface.
 *
 * Far from a contact the nodes do not rest: the network's tension falls as one over the distance
 * squared, so that on an organ of 100 mm no node is below 1e-4 of the largest displacement. But
 * they all do the same. With r = b + L u and L u << b, node i far away obeys
 *
 *   m_i u'' + gamma_i u' + ks_i u = -T(t) b_i - p(t) N_i       T = c1 - c2 = a E^ eps+ (a source)
 *
 * and where gamma/m and ks/m are the same for all nodes, its motion is known from two numbers a
 * source, the mode y_k of source k (and one of the pressure, with N for b):
 *
 *   u_i = -sum_k y_k b_k,i / m_i,      y_k'' + (gamma/m) y_k' + (ks/m) y_k = T_k
 *
 * So a node is either active, with its own u and v, or still: it follows the modes. The modes are
 * coordinates of the same potential: with G_kl = sum over still nodes b_k.b_l / m they add
 * -sum_l y_l G_lk to eps_k, w G w / 2 to the kinetic energy, (ks/m) y G y / 2 to the elastic one
 * and (gamma/m) w G w to the losses, and Runge-Kutta takes them along. Force, energy and pressure
 * of the far field are therefore all there, and the energy balance closes; what is neglected is the
 * force c1 L u on still nodes alone.
 *
 * Blocks of 64 consecutive nodes are active or still as a whole. At every fourth sub-step, and
 * sooner when the tension grows by half, each active block, and each still one beside an active
 * one, is asked how far its nodes are from their places in the far field, |u - u_far|^2 + (m/ks) |v
 * - v_far|^2, and how far the neglected force would take them, |F| / ks; for all others the latter
 * is known from what it is in modes of unit size (it is not small beside held cells, however far
 * from the contact). Beyond the tolerance times the largest displacement a still block becomes
 * active, from its place in the far field, without a jump; below half of it an active one becomes
 * still, and steps into its place, by less than that. What this changes in the energy is booked as
 * loss. Blocks with loaded, prescribed or partly fixed nodes stay active.
 *
 * While blocks change they are looked at after every sub-step, and a front then moves one block (8
 * edges) in each; a sub-step of Runge-Kutta within its bound moves anything felt by less than an
 * edge.
 *
 * Rejected: still nodes that keep their displacement (on an organ with 20,000 nodes, pushed 7 mm,
 * all 17,062 free ones are above 1e-4, and above 1e-5; after the modes are taken out those near the
 * contact are left, see the scaling report); lists of nodes in place of blocks (rows and nodes then
 * no longer stream, and every list would have to be rebuilt at each change).
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"

/* Sub-steps from one look at the blocks to the next. */
enum { LOOK_EVERY = 4 };
/* Or as soon as the tension of all sources is so many times what it was at the last look. */
#define GROWN 1.5
/* Of the tolerance, where an active block becomes still. */
#define STILL_SHARE 0.5
/* Mean edges: below this displacement the tolerance no longer shrinks (float holds it well). */
#define FLOOR_EDGES 1e-4
/* Relative spread of gamma/m and ks/m that counts as the same. */
#define SAME_RATE 1e-6
enum { ACTIVE = 0, BESIDE = 1, NEXT = 2, FAR = 3 };

/* ---- set-up ---- */

/* Are gamma/m and ks/m the same for all nodes, and ks not 0? */
static bool find_rates(const ss_model *model, double *out_damping_rate, double *out_rate2)
{
    const ss_cnn_material *m = &model->material;
    double low[2] = {(double)INFINITY, (double)INFINITY}, high[2] = {0.0, 0.0};
    for (int32_t i = 0; i < model->node_count; ++i) {
        if (!(m->mass[i] > 0.0)) {
            continue;
        }
        const double rate[2] = {m->damping[i] / m->mass[i], m->rest_stiffness[i] / m->mass[i]};
        for (int k = 0; k < 2; ++k) {
            low[k] = fmin(low[k], rate[k]);
            high[k] = fmax(high[k], rate[k]);
        }
    }
    *out_damping_rate = low[0];
    *out_rate2 = low[1];
    return low[1] > 0.0 && high[1] <= (1.0 + SAME_RATE) * low[1] &&
           high[0] <= (1.0 + SAME_RATE) * low[0];
}

/* Why this plan has no active set; NULL where it may have one. */
static const char *find_reason(const ss_model *model, double *out_damping_rate, double *out_rate2)
{
    const bool has_tool = ss_plan_tool_count(&model->plan) > 0;
    if (model->network->rows.block_count == 1) {
        return "a small body";
    }
    if (model->material.window_tolerance == 0.0) {
        return "window_tolerance is 0";
    }
    if (has_tool) {
        return "a tool moves the sources";
    }
    if (model->is_relaxed) {
        return "the sources develop in the network's own time";
    }
    if (model->has_gravity || !model->is_held) {
        return model->has_gravity ? "gravity moves every node" : "the body is free";
    }
    if (model->enclosed_count > 1) {
        return "several bodies enclose a volume each";
    }
    if (model->source_count + (model->normal ? 1 : 0) > SS_CNN_MAX_MODES) {
        return "too many loads";
    }
    if (!find_rates(model, out_damping_rate, out_rate2)) {
        return "damping and rest stiffness over mass differ from node to node, or are 0";
    }
    return NULL;
}

static void pin(ss_cnn_active_set *set, int32_t count, const int32_t *node)
{
    for (int32_t k = 0; k < count; ++k) {
        set->is_pinned[node[k] / set->block_size] = 1;
    }
}

static void pin_blocks(const ss_model *model, ss_cnn_active_set *set)
{
    pin(set, model->loads.node_count, model->loads.node);
    for (int32_t p = 0; p < model->plan.prescribed_count; ++p) {
        pin(set, model->plan.prescribed[p].node_count, model->plan.prescribed[p].node);
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        const int axes = model->plan.fixed[i] & 7;
        if (axes != 0 && axes != 7) {
            pin(set, 1, &i);
        }
    }
}

/* Adds block `b` to the neighbours of `a`, counted from near_first[a]; each once. */
static void add_near(ss_cnn_active_set *set, int32_t *count, int32_t a, int32_t b)
{
    int32_t *near = set->near + set->near_first[a];
    for (int32_t k = 0; k < count[a]; ++k) {
        if (near[k] == b) {
            return;
        }
    }
    near[count[a]++] = b;
}

static softsim_status find_near_blocks(ss_model *model, ss_cnn_active_set *set)
{
    const ss_cnn_edges *edges = &model->network->edges;
    const int32_t size = set->block_size;
    int32_t *count = ss_memory_get((size_t)set->block_count, sizeof *count);
    set->near_first = ss_arena_get(&model->arena, (size_t)set->block_count + 1, sizeof(int32_t));
    if (!count || !set->near_first) {
        ss_memory_free(count);
        return SOFTSIM_ERROR_MEMORY;
    }
    /* Room for every edge that crosses, then the ranges are closed up. */
    for (int32_t e = 0; e < edges->count; ++e) {
        const int32_t a = edges->from[e] / 4 / size, b = edges->to[e] / 4 / size;
        set->near_first[a + 1] += a != b;
        set->near_first[b + 1] += a != b;
    }
    for (int32_t k = 0; k < set->block_count; ++k) {
        set->near_first[k + 1] += set->near_first[k];
    }
    const size_t crossing = (size_t)set->near_first[set->block_count];
    set->near = ss_arena_get(&model->arena, crossing, sizeof *set->near);
    for (int32_t e = 0; set->near && e < edges->count; ++e) {
        const int32_t a = edges->from[e] / 4 / size, b = edges->to[e] / 4 / size;
        if (a != b) {
            add_near(set, count, a, b);
            add_near(set, count, b, a);
        }
    }
    int32_t end = 0;
    for (int32_t k = 0; set->near && k < set->block_count; ++k) {
        const int32_t first = set->near_first[k];
        set->near_first[k] = end;
        memmove(set->near + end, set->near + first, (size_t)count[k] * sizeof(int32_t));
        end += count[k];
    }
    set->near_first[set->block_count] = end;
    ss_memory_free(count);
    return set->near ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

/* The modes' force vectors f_m, and their Gram matrix per block. */
static void set_modes(ss_model *model, ss_cnn_active_set *set)
{
    const int32_t count = set->mode_count;
    for (int32_t m = 0; m < count; ++m) {
        set->f[m] = m < model->source_count ? model->source[m].b : model->normal;
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        double *gram = set->gram + (size_t)(i / set->block_size) * (size_t)(count * count);
        for (int32_t m = 0; m < count; ++m) {
            for (int32_t l = 0; l < count; ++l) {
                for (ptrdiff_t at = 4 * (ptrdiff_t)i; at < 4 * (ptrdiff_t)i + 3; ++at) {
                    gram[m * count + l] +=
                        (double)set->f[m][at] * (double)set->f[l][at] * (double)model->mobility[at];
                }
            }
        }
    }
}

/* What modes of unit size would do to a block through source k: see far_drive. */
static void add_mode_error(const ss_model *model, const ss_cnn_active_set *set, int32_t k,
                           ss_cnn_mode_error *mode_error)
{
    for (int32_t block = 0; block < set->block_count; ++block) {
        const int32_t first = block * set->block_size, next = first + set->block_size;
        const int32_t end = next < model->node_count ? next : model->node_count;
        double sum[3] = {0.0, 0.0, 0.0};
        for (int32_t i = first; i < end; ++i) {
            const ptrdiff_t at = 4 * (ptrdiff_t)i;
            const double stiffness = (double)model->source[k].b[at + 3];
            double alone = 0.0, together = 0.0;
            for (int a = 0; a < 3; ++a) {
                const double force = (double)model->product[at + a];
                const double way = force * (double)model->mobility[at + a] / set->rate2;
                sum[a] += way / set->block_size;
                alone += way * way;
                together += model->mobility[at + a] > 0 ? force * force : 0.0;
            }
            mode_error->alone = fmax(mode_error->alone, sqrt(alone));
            mode_error->shared = stiffness > 0.0
                                     ? fmax(mode_error->shared, sqrt(together) / stiffness)
                                     : mode_error->shared;
        }
        mode_error->mean = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
        mode_error += model->source_count * set->mode_count;
    }
}

static void set_mode_errors(ss_model *model, ss_cnn_active_set *set)
{
    const ss_cnn_kernels *kernels = model->kernels;
    for (int32_t l = 0; l < set->mode_count; ++l) {
        const double one = 1.0;
        kernels->follow(&model->whole, 1, &set->f[l], &one, &one, model->mobility, model->us,
                        model->vs[0]);
        for (int32_t k = 0; k < model->source_count; ++k) {
            double ub, ur;
            kernels->product(&model->network->rows, &model->whole, model->source[k].kap, NULL,
                             model->us, model->product, &ub, &ur);
            add_mode_error(model, set, k, set->mode_error + k * set->mode_count + l);
        }
    }
    const size_t bytes = ss_cnn_padded(model->node_count) * 4 * sizeof(ss_real);
    memset(model->us, 0, bytes);
    memset(model->vs[0], 0, bytes);
    memset(model->product, 0, bytes);
}

static softsim_status allocate(ss_model *model, ss_cnn_active_set *set)
{
    const size_t blocks = (size_t)set->block_count, spans = blocks / 2 + 1;
    const size_t modes = (size_t)set->mode_count;
    const size_t mode_errors = blocks * modes * (size_t)model->source_count;
    ss_arena *arena = &model->arena;
    ss_cnn_part *const part[] = {&set->active, &set->beside, &set->rim, &set->still};
    for (size_t k = 0; k < sizeof part / sizeof *part; ++k) {
        part[k]->span = ss_arena_get(arena, spans, sizeof *part[k]->span);
    }
    SS_ARENA_TAKE(arena, SS_ROOM(blocks, set->is_pinned), SS_ROOM(blocks, set->distance),
                  SS_ROOM(blocks, set->unrest), SS_ROOM(blocks * modes * modes, set->gram),
                  SS_ROOM(mode_errors, set->mode_error),
                  SS_ROOM((size_t)model->node_count, set->seam),
                  SS_ROOM((size_t)model->node_count, set->is_seam));
    return ss_arena_status(arena);
}

softsim_status ss_cnn_active_set_create(ss_model *model)
{
    const ss_cnn_rows *rows = &model->network->rows;
    double damping_rate = 0.0, rate2 = 0.0;
    model->no_set_reason = find_reason(model, &damping_rate, &rate2);
    if (model->no_set_reason) {
        return SOFTSIM_OK;
    }
    ss_cnn_active_set *set = model->set = ss_arena_get(&model->arena, 1, sizeof *set);
    if (!set) {
        return SOFTSIM_ERROR_MEMORY;
    }
    set->block_count = rows->block_count;
    set->block_size = rows->block_size;
    set->tolerance = model->material.window_tolerance;
    set->floor = FLOOR_EDGES * model->network->mean_edge;
    set->damping_rate = damping_rate;
    set->rate2 = rate2;
    set->mode_count = model->source_count + (model->normal ? 1 : 0);
    softsim_status status = allocate(model, set);
    status = status == SOFTSIM_OK ? find_near_blocks(model, set) : status;
    if (status == SOFTSIM_OK) {
        pin_blocks(model, set);
        set_modes(model, set);
        set_mode_errors(model, set);
    }
    return status;
}

/* ---- parts ---- */

/* The blocks of distances low to high, consecutive ones as one span. */
static void set_part(const ss_model *model, int low, int high, ss_cnn_part *part)
{
    const ss_cnn_active_set *set = model->set;
    const int32_t end = (int32_t)ss_cnn_padded(model->node_count);
    bool is_open = false;
    part->count = 0;
    for (int32_t k = 0; k < set->block_count; ++k) {
        const bool is_in = set->distance[k] >= low && set->distance[k] <= high;
        const int32_t next = (k + 1) * set->block_size;
        if (is_in && !is_open) {
            part->span[part->count++] = (ss_cnn_span){.node = k * set->block_size,
                                                      .group = model->network->rows.block_group[k]};
        }
        if (is_in) {
            ss_cnn_span *span = &part->span[part->count - 1];
            span->node_end = next < end ? next : end;
            span->group_end = model->network->rows.block_group[k + 1];
        }
        is_open = is_in;
    }
}

/* Still nodes that share an edge with an active one. */
static void find_seam(const ss_model *model)
{
    ss_cnn_active_set *set = model->set;
    const ss_cnn_rows *rows = &model->network->rows;
    for (int32_t k = 0; k < set->seam_count; ++k) {
        set->is_seam[set->seam[k] / 4] = 0;
    }
    set->seam_count = 0;
    for (int32_t s = 0; s < set->active.count; ++s) {
        const ss_cnn_span *span = &set->active.span[s];
        for (int32_t g = span->group; g < span->group_end; ++g) {
            const ss_cnn_group *group = &rows->group[g];
            const int32_t end = group->first_entry + group->degree * group->row_count;
            for (int32_t e = group->first_entry; e < end; ++e) {
                const int32_t node = rows->neighbour[e] / 4;
                if (set->distance[node / set->block_size] != ACTIVE && !set->is_seam[node]) {
                    set->is_seam[node] = 1;
                    set->seam[set->seam_count++] = 4 * node;
                }
            }
        }
    }
}

/* Distances of the still blocks from the active ones, and all that follows from them. */
static void set_parts(ss_model *model)
{
    ss_cnn_active_set *set = model->set;
    const int32_t modes = set->mode_count;
    for (int32_t k = 0; k < set->block_count; ++k) {
        set->distance[k] = set->distance[k] == ACTIVE ? ACTIVE : FAR;
    }
    for (uint8_t from = ACTIVE; from < NEXT; ++from) {
        for (int32_t k = 0; k < set->block_count; ++k) {
            for (int32_t n = set->near_first[k];
                 set->distance[k] == from && n < set->near_first[k + 1]; ++n) {
                uint8_t *near = &set->distance[set->near[n]];
                *near = *near == FAR ? (uint8_t)(from + 1) : *near;
            }
        }
    }
    set_part(model, ACTIVE, ACTIVE, &set->active);
    set_part(model, BESIDE, BESIDE, &set->beside);
    set_part(model, BESIDE, NEXT, &set->rim);
    set_part(model, BESIDE, FAR, &set->still);
    find_seam(model);
    set->active_nodes = 0;
    for (int32_t s = 0; s < set->active.count; ++s) { /* the end may be one beyond the last */
        const ss_cnn_span *span = &set->active.span[s];
        const int32_t end = span->node_end < model->node_count ? span->node_end : model->node_count;
        set->active_nodes += end - span->node;
    }
    memset(set->shared, 0, sizeof set->shared);
    for (int32_t k = 0; k < set->block_count; ++k) {
        const double *gram = set->gram + (size_t)k * (size_t)(modes * modes);
        for (int32_t m = 0; set->distance[k] != ACTIVE && m < modes * modes; ++m) {
            set->shared[m / modes][m % modes] += gram[m];
        }
    }
    set->is_filled = false;
}

void ss_cnn_active_set_reset(ss_model *model)
{
    ss_cnn_active_set *set = model->set;
    if (!set) {
        return;
    }
    for (int32_t k = 0; k < set->block_count; ++k) {
        set->distance[k] = set->is_pinned[k] ? ACTIVE : FAR;
    }
    memset(set->y, 0, sizeof set->y);
    memset(set->w, 0, sizeof set->w);
    memset(set->now_y, 0, sizeof set->now_y);
    memset(set->now_w, 0, sizeof set->now_w);
    set->age = 0;
    set->tension = 0.0;
    set_parts(model);
    model->part = &set->active;
}

/* ---- the far field in a step ---- */

/* sum over the still nodes of u.f_m, with u from the modes' `y`. */
static double far_product(const ss_cnn_active_set *set, const double *y, int32_t m)
{
    double sum = 0.0;
    for (int32_t l = 0; l < set->mode_count; ++l) {
        sum -= y[l] * set->shared[l][m];
    }
    return sum;
}

/* sum over the still nodes of m |u|^2, with u from the modes' `y`. */
static double far_square(const ss_cnn_active_set *set, const double *y)
{
    double sum = 0.0;
    for (int32_t m = 0; m < set->mode_count; ++m) {
        sum -= y[m] * far_product(set, y, m);
    }
    return sum;
}

double ss_cnn_active_set_evaluate(ss_model *model, ss_real *u)
{
    const ss_cnn_active_set *set = model->set;
    if (!set) {
        return 0.0;
    }
    model->kernels->follow_nodes(set->seam_count, set->seam, set->mode_count, set->f, set->now_y,
                                 model->mobility, u);
    for (int32_t k = 0; k < model->source_count; ++k) {
        model->source[k].far = far_product(set, set->now_y, k);
    }
    return model->normal ? far_product(set, set->now_y, set->mode_count - 1) : 0.0;
}

double ss_cnn_active_set_stage(ss_model *model, int index, double h)
{
    static const double next[3] = {0.5, 0.5, 1.0}, share[4] = {1.0, 2.0, 2.0, 1.0};
    ss_cnn_active_set *set = model->set;
    if (!set) {
        return 0.0;
    }
    const double power = set->damping_rate * far_square(set, set->now_w);
    for (int32_t m = 0; m < set->mode_count; ++m) {
        const ss_cnn_source *source = m < model->source_count ? &model->source[m] : NULL;
        const double tension = !source         ? model->enclosed[0].pressure
                               : source->is_on ? source->c1 - source->c2
                                               : 0.0;
        const double rate = set->now_w[m];
        const double a = tension - set->damping_rate * rate - set->rate2 * set->now_y[m];
        set->sum_y[m] = (index == 0 ? 0.0 : set->sum_y[m]) + share[index] * rate;
        set->sum_w[m] = (index == 0 ? 0.0 : set->sum_w[m]) + share[index] * a;
        if (index < 3) {
            set->now_y[m] = set->y[m] + next[index] * h * rate;
            set->now_w[m] = set->w[m] + next[index] * h * a;
        } else {
            set->old_y[m] = set->y[m] + h / 6.0 * set->sum_y[m];
            set->old_w[m] = set->w[m] + h / 6.0 * set->sum_w[m];
        }
    }
    return power;
}

void ss_cnn_active_set_swap(ss_model *model)
{
    ss_cnn_active_set *set = model->set;
    if (!set) {
        return;
    }
    for (int32_t m = 0; m < set->mode_count; ++m) {
        const double y = set->y[m], w = set->w[m];
        set->now_y[m] = set->y[m] = set->old_y[m];
        set->now_w[m] = set->w[m] = set->old_w[m];
        set->old_y[m] = y;
        set->old_w[m] = w;
    }
    set->is_filled = false;
}

void ss_cnn_active_set_damp(ss_model *model, double factor)
{
    for (int32_t m = 0; model->set && m < model->set->mode_count; ++m) {
        model->set->now_w[m] = model->set->w[m] *= factor;
    }
}

void ss_cnn_active_set_add_totals(const ss_model *model, ss_cnn_totals *totals)
{
    if (model->set) {
        totals->kinetic += far_square(model->set, model->set->w);
        totals->rest += model->set->rate2 * far_square(model->set, model->set->y);
    }
}

double ss_cnn_active_set_stiffness(const ss_model *model, int32_t index)
{
    return model->set ? model->set->shared[index][index] : 0.0;
}

void ss_cnn_active_set_fill(const ss_model *model)
{
    ss_cnn_active_set *set = model->set;
    if (set && !set->is_filled) {
        model->kernels->follow(&set->still, set->mode_count, set->f, set->y, set->w,
                               model->mobility, model->u, model->v);
        set->is_filled = true;
    }
}

/* ---- choice of blocks ---- */

/* Forces that the far field does not have, into model->product: loads, and -c1 L u. */
static void find_drives(ss_model *model, const ss_cnn_part *part)
{
    const ss_cnn_kernels *kernels = model->kernels;
    for (int32_t s = 0; s < part->count; ++s) {
        const ptrdiff_t at = 4 * (ptrdiff_t)part->span[s].node;
        const ptrdiff_t end = 4 * (ptrdiff_t)part->span[s].node_end;
        memcpy(model->product + at, model->load_force + at,
               (size_t)(end - at) * sizeof *model->product);
    }
    for (int32_t k = 0; k < model->source_count; ++k) {
        const ss_cnn_source *source = &model->source[k];
        if (source->is_on && source->c1 > 0.0) {
            kernels->neglect(part, source->c1, source->r, source->b, model->product);
        }
    }
}

/* Unrest of every active block and of those beside, at the present state. */
static void find_unrest(ss_model *model)
{
    ss_cnn_active_set *set = model->set;
    const ss_cnn_kernels *kernels = model->kernels;
    const ss_cnn_part *const part[2] = {&set->active, &set->beside};
    kernels->follow(&set->rim, set->mode_count, set->f, set->y, set->w, model->mobility, model->u,
                    model->v);
    for (int32_t k = 0; k < model->source_count; ++k) {
        double ub, ur;
        const ss_cnn_source *source = &model->source[k];
        if (source->is_on) {
            kernels->product(&model->network->rows, &set->beside, source->kap, source->b, model->u,
                             source->r, &ub, &ur);
        }
    }
    for (int p = 0; p < 2; ++p) {
        find_drives(model, part[p]);
        kernels->follow(part[p], set->mode_count, set->f, set->y, set->w, model->mobility,
                        model->us, model->vs[0]);
    }
    const int32_t end = (int32_t)ss_cnn_padded(model->node_count);
    for (int32_t k = 0; k < set->block_count; ++k) {
        const int32_t first = k * set->block_size, next = first + set->block_size;
        if (set->distance[k] <= BESIDE) {
            kernels->watch(first, next < end ? next : end, set->rate2, model->u, model->v,
                           model->us, model->vs[0], model->product, model->mobility,
                           &set->unrest[k]);
        }
    }
}

/* From its place in the far field. */
static void wake_block(ss_model *model, int32_t k)
{
    ss_cnn_active_set *set = model->set;
    const int32_t size = set->block_size, end = (int32_t)ss_cnn_padded(model->node_count);
    const int32_t first = k * size, next = first + size < end ? first + size : end;
    ss_cnn_span span = {.node = first, .node_end = next};
    const ss_cnn_part part = {.count = 1, .span = &span};
    model->kernels->follow(&part, set->mode_count, set->f, set->y, set->w, model->mobility,
                           model->u, model->v);
    memset(model->u_low + 4 * (ptrdiff_t)first, 0,
           (size_t)(next - first) * 4 * sizeof *model->u_low);
    set->distance[k] = ACTIVE;
}

/* How far the far field by itself would take a node of block `k` out of its place, m^2: as much as
 * `alone` where the node's own ks holds it, as `shared` where its neighbours do, and all of them
 * together by `mean`. */
static double far_drive(const ss_model *model, int32_t k)
{
    const ss_cnn_active_set *set = model->set;
    const ss_cnn_mode_error *mode_error =
        set->mode_error + (ptrdiff_t)k * model->source_count * set->mode_count;
    double rough = 0.0, mean = 0.0;
    for (int32_t s = 0; s < model->source_count; ++s) {
        const double c1 = model->source[s].is_on ? model->source[s].c1 : 0.0;
        for (int32_t l = 0; l < set->mode_count; ++l, ++mode_error) {
            const double y = fabs(set->y[l]), alone = c1 * mode_error->alone;
            rough +=
                alone > 0.0 ? y * alone * mode_error->shared / (alone + mode_error->shared) : 0.0;
            mean += y * c1 * mode_error->mean;
        }
    }
    return fmax(rough, mean) * fmax(rough, mean);
}

/* Is it time to look at the blocks, or has the tension grown since? */
static bool is_due(const ss_model *model)
{
    ss_cnn_active_set *set = model->set;
    double tension = 0.0;
    for (int32_t k = 0; k < model->source_count; ++k) {
        tension += model->source[k].is_on ? model->source[k].c1 : 0.0;
    }
    if (++set->age < LOOK_EVERY && !(tension > GROWN * set->tension)) {
        return false;
    }
    set->age = 0;
    set->tension = tension;
    return true;
}

bool ss_cnn_active_set_look(ss_model *model)
{
    ss_cnn_active_set *set = model->set;
    if (!set || !is_due(model)) {
        return false;
    }
    find_unrest(model);
    double largest = set->floor * set->floor;
    for (int32_t k = 0; k < set->block_count; ++k) {
        largest = set->distance[k] == ACTIVE ? fmax(largest, set->unrest[k].displacement) : largest;
    }
    const double wake = set->tolerance * set->tolerance * largest;
    const double rest = STILL_SHARE * STILL_SHARE * wake;
    bool is_changed = false;
    for (int32_t k = 0; k < set->block_count; ++k) {
        const ss_cnn_unrest *unrest = &set->unrest[k];
        const double far = far_drive(model, k);
        if (set->distance[k] == ACTIVE && !set->is_pinned[k] && unrest->motion < rest &&
            unrest->drive < rest && far < rest) {
            set->distance[k] = FAR;
            is_changed = true;
        } else if (set->distance[k] != ACTIVE &&
                   (far > wake || (set->distance[k] == BESIDE && unrest->drive > wake))) {
            wake_block(model, k);
            is_changed = true;
        }
    }
    if (is_changed) {
        set_parts(model);
        set->age = LOOK_EVERY - 1; /* while a front moves it is followed */
    }
    return is_changed;
}
