/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * What acts on the body without a tool: forces on nodes, pressure on patches, gravity, prescribed
 * nodes; and what the supports answer.
 *
 * A load's nodes, or a prescribed patch, are a source of the network with fixed weights: equal ones
 * for a force, by area for a pressure; or, with `source: contact`, the one cell among them that
 * lies nearest their centre (Zhong et al. 2006, equation 10), while the force stays on all of
 * them. A load of 0 N has none: it would only stiffen what tools feel. It is switched on when the
 * load first acts and stays on (the strain it has caused must be undone after the force is gone);
 * what it holds at that moment is booked as work. Loads on the same nodes share one source: a force
 * and the force that takes it back are one contact. Pressure follows the deformed surface, once per
 * step. Prescribed axes move at constant velocity through a step: with their mobility at 0, RK4
 * follows them exactly.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "models/common/plan.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* rho on an edge over rho at the loaded cell: the contact softens above, and fails far above. */
#define RHO_RATIO_MAX 10.0

/* ---- sources ---- */

/* Cells and weights of one source while it is built. */
typedef struct patch {
    int32_t count;
    int32_t *node;  /* increasing */
    double *weight; /* sum 1 */
} patch;

/* Leaves the cell nearest the centre of raw[node] > 0; the lower number where two are as near. */
static void keep_contact_cell(const ss_model *model, const double *raw, patch *out)
{
    const double(*rest)[3] = (const double(*)[3])model->plan.mesh->position;
    double centre[3] = {0.0}, sum = 0.0, nearest = (double)INFINITY;
    for (int32_t i = 0; i < model->node_count; ++i) {
        sum += raw[i] > 0.0 ? raw[i] : 0.0;
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        if (raw[i] > 0.0) {
            ss_madd3(centre, centre, raw[i] / sum, rest[i]);
        }
    }
    int32_t contact = -1;
    for (int32_t k = 0; k < out->count; ++k) {
        double away[3];
        ss_sub3(away, rest[out->node[k]], centre);
        const double distance = ss_norm3(away);
        contact = distance < nearest ? out->node[k] : contact;
        nearest = fmin(nearest, distance);
    }
    if (contact >= 0) {
        out->node[0] = contact;
        out->weight[0] = 1.0;
        out->count = 1;
    }
}

/* Turns raw[node] > 0 into a patch over the cells that can carry a source. */
static void fill_patch(const ss_model *model, const double *raw, patch *out)
{
    double sum = 0.0;
    out->count = 0;
    for (int32_t i = 0; i < model->node_count; ++i) {
        if (raw[i] > 0.0 && model->network->is_source[i]) {
            out->node[out->count] = i;
            out->weight[out->count++] = raw[i];
            sum += raw[i];
        }
    }
    for (int32_t k = 0; k < out->count; ++k) {
        out->weight[k] /= sum;
    }
    if (model->is_one_cell) {
        keep_contact_cell(model, raw, out);
    }
}

/* The areas of the triangles under pressure as weights. */
static void weigh_triangles(const ss_model *model, const ss_acting_load *load, double *raw)
{
    const ss_mesh *mesh = model->plan.mesh;
    for (int32_t t = 0; t < load->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[load->triangle[t]];
        double n[3];
        ss_normal3(n, mesh->position[c[0]], mesh->position[c[1]], mesh->position[c[2]]);
        for (int k = 0; k < 3; ++k) {
            raw[c[k]] += ss_norm3(n);
        }
    }
}

/* A cell whose neighbourhood conducts far better than itself has almost no contact stiffness. */
static void check_rho(const ss_model *model, const patch *cells, int32_t which,
                      softsim_error *error)
{
    for (int32_t k = 0; k < cells->count; ++k) {
        const double ratio =
            model->network->largest_rho / ss_cnn_best_rho(&model->material, cells->node[k]);
        if (ratio > RHO_RATIO_MAX) {
            softsim_error_add(
                error, SOFTSIM_ERROR_SCENE,
                "cnn-energy: rho at node %d, where load %d acts, is %.3g times smaller "
                "than elsewhere (at most %g): the contact would be without stiffness",
                ss_mesh_file_node(model->plan.mesh, cells->node[k]), which, ratio, RHO_RATIO_MAX);
            return;
        }
    }
}

/* The source over `cells`: one that exists already over the same nodes, or a new one. */
static softsim_status find_source(ss_model *model, const patch *cells, double from,
                                  int32_t *out_source)
{
    *out_source = -1;
    if (cells->count == 0) {
        return SOFTSIM_OK;
    }
    for (int32_t k = 0; k < model->source_count; ++k) {
        const size_t bytes = (size_t)cells->count * sizeof *cells->node;
        const size_t weights = (size_t)cells->count * sizeof *cells->weight;
        ss_cnn_source *known = &model->source[k];
        if (known->cell_count == cells->count && memcmp(known->cell, cells->node, bytes) == 0 &&
            memcmp(known->cell_weight, cells->weight, weights) == 0) {
            known->from = fmin(known->from, from);
            *out_source = k;
            return SOFTSIM_OK;
        }
    }
    const int32_t index = model->source_count++;
    model->source[index].from = from;
    *out_source = index;
    return ss_cnn_source_fix(model, cells->count, cells->node, cells->weight,
                             &model->source[index]);
}

static softsim_status create_load(ss_model *model, int32_t which, patch *cells, double *raw,
                                  softsim_error *error)
{
    const ss_acting_load *load = &model->loads.load[which];
    int32_t unused;
    memset(raw, 0, (size_t)model->node_count * sizeof *raw);
    if (load->plan->is_pressure) {
        weigh_triangles(model, load, raw);
    } else {
        for (int32_t k = 0; k < load->plan->node_count; ++k) {
            raw[load->plan->node[k]] = 1.0;
        }
    }
    fill_patch(model, raw, cells);
    if (!load->plan->is_pressure && cells->count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: load %d acts on no node of the surface that has an area",
                          which);
        return SOFTSIM_ERROR_SCENE;
    }
    check_rho(model, cells, which, error);
    if (!ss_load_pushes(load->plan)) {
        return SOFTSIM_OK; /* a source that nothing feeds would stiffen what tools feel */
    }
    return find_source(model, cells, load->plan->from, &unused);
}

static softsim_status create_prescribed(ss_model *model, int32_t which, patch *cells, double *raw)
{
    ss_cnn_prescribed *prescribed = &model->prescribed[which];
    const ss_prescribed *set = &model->plan.prescribed[which];
    ss_prescribed_set_init(&prescribed->set, set, &model->arena);
    memset(raw, 0, (size_t)model->node_count * sizeof *raw);
    for (int32_t i = 0; i < set->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (ss_plan_is_prescribed(set, i, k)) {
                raw[set->node[i]] = 1.0;
                model->mobility[4 * (ptrdiff_t)set->node[i] + k] = 0;
            }
        }
    }
    fill_patch(model, raw, cells);
    return find_source(model, cells, set->from, &prescribed->source);
}

softsim_status ss_cnn_loads_create(ss_model *model, softsim_error *error)
{
    const ss_model_plan *plan = &model->plan;
    const size_t limit = (size_t)plan->load_count + (size_t)plan->prescribed_count;
    const int32_t before = error->fault_count;
    ss_arena scratch = {0};
    const size_t n = (size_t)model->node_count;
    patch cells = {.node = ss_arena_get(&scratch, n, sizeof *cells.node),
                   .weight = ss_arena_get(&scratch, n, sizeof *cells.weight)};
    double *raw = ss_arena_get(&scratch, n, sizeof *raw);
    ss_arena *arena = &model->arena;
    model->prescribed =
        ss_arena_get(arena, (size_t)plan->prescribed_count, sizeof *model->prescribed);
    model->source = ss_arena_get(arena, limit, sizeof *model->source);
    softsim_status status = ss_arena_status(&scratch);
    status = status == SOFTSIM_OK ? ss_loads_create(&model->loads, plan, "cnn-energy",
                                                    model->has_gravity, arena, error)
                                  : status;
    for (int32_t k = 0; status == SOFTSIM_OK && k < plan->load_count; ++k) {
        status = create_load(model, k, &cells, raw, error);
    }
    for (int32_t k = 0; status == SOFTSIM_OK && k < plan->prescribed_count; ++k) {
        status = create_prescribed(model, k, &cells, raw);
    }
    ss_arena_free(&scratch);
    status = status == SOFTSIM_OK ? ss_arena_status(arena) : status;
    return status == SOFTSIM_OK && error->fault_count > before ? SOFTSIM_ERROR_SCENE : status;
}

/* ---- forces ---- */

static void add_node_force(ss_real *force, int32_t node, const double f[3])
{
    for (int k = 0; k < 3; ++k) {
        force[4 * (ptrdiff_t)node + k] += (ss_real)f[k];
    }
}

bool ss_cnn_loads_update(ss_model *model, double time)
{
    for (int32_t k = 0; k < model->source_count; ++k) {
        ss_cnn_source *source = &model->source[k];
        if (!source->is_on && time >= source->from) {
            source->is_on = true;
            model->is_ready = false;
        }
    }
    return ss_loads_update(&model->loads, time);
}

void ss_cnn_loads_build(ss_model *model)
{
    ss_loads_clear(&model->loads, model->load_force);
    for (int32_t i = 0; model->has_gravity && i < model->node_count; ++i) {
        double f[3];
        ss_scale3(f, model->plan.gravity, model->material.mass[i]);
        add_node_force(model->load_force, i, f);
    }
    ss_loads_add(&model->loads, model->u, 1.0, model->load_force);
}

double ss_cnn_loads_work(const ss_model *model)
{
    double work = 0.0;
    for (int32_t k = 0; k < model->loads.node_count; ++k) {
        const ptrdiff_t at = 4 * (ptrdiff_t)model->loads.node[k];
        for (ptrdiff_t a = at; a < at + 3; ++a) {
            const double moved = ((double)model->u[a] - (double)model->old_u[a]) +
                                 ((double)model->u_low[a] - (double)model->old_low[a]);
            work += (double)model->load_force[a] * moved;
        }
    }
    return work;
}

/* ---- prescribed nodes ---- */

void ss_cnn_prescribed_update(ss_model *model, double time)
{
    for (int32_t p = 0; p < model->plan.prescribed_count; ++p) {
        ss_prescribed_set_aim(&model->prescribed[p].set, model->u, time);
    }
}

void ss_cnn_prescribed_place(ss_model *model, double path, double fraction, double h)
{
    for (int32_t p = 0; p < model->plan.prescribed_count; ++p) {
        const double work = ss_prescribed_set_place(&model->prescribed[p].set, path, fraction, h,
                                                    model->material.mass, model->u, model->v);
        model->work += work;
        model->load_work += work;
    }
}

/* What a support at node `i` must push with so that the node follows it, at the last evaluation. */
static void support_at(const ss_model *model, int32_t i, const ss_real *d, const ss_real *v,
                       double out[3])
{
    const ptrdiff_t at = 4 * (ptrdiff_t)i;
    const ss_cnn_source *first = model->first;
    const ss_real *normal = ss_cnn_enclosed_normal(model);
    for (int k = 0; k < 3; ++k) {
        out[k] = (double)model->rest_stiffness[i] * (double)d[at + k] +
                 (double)model->damping[i] * (double)v[at + k] - (double)model->force[at + k];
        if (first) {
            const ss_real *b = first->b_turned ? first->b_turned : first->b;
            out[k] += first->c1 * (double)first->r[at + k] - first->c2 * (double)b[at + k];
        }
        if (normal) {
            out[k] += model->enclosed[0].pressure * (double)normal[at + k];
        }
    }
}

double ss_cnn_prescribed_work(const ss_model *model, const ss_real *d, const ss_real *v, double h,
                              double share)
{
    double power = 0.0;
    for (int32_t p = 0; p < model->plan.prescribed_count; ++p) {
        const ss_prescribed *set = model->prescribed[p].set.plan;
        for (int32_t i = 0; i < set->node_count; ++i) {
            double support[3];
            support_at(model, set->node[i], d, v, support);
            for (int k = 0; k < 3; ++k) {
                if (ss_plan_is_prescribed(set, i, k)) {
                    power += support[k] * (double)v[4 * (ptrdiff_t)set->node[i] + k];
                }
            }
        }
    }
    return power * h * share;
}

/* ---- reactions ---- */

/* Forces of the network on held cells, whose rows the stages leave out: c1 r - c2 b, summed. */
static void add_held_network(const ss_model *model, double out_force[3])
{
    const ss_cnn_source *list[SOFTSIM_MAX_PROBES];
    int32_t count = 0;
    for (int t = 0; t < SOFTSIM_MAX_PROBES; ++t) {
        if (model->tool[t].source.is_on) {
            list[count++] = &model->tool[t].source;
        }
    }
    for (int32_t s = 0; s < model->source_count + count; ++s) {
        const ss_cnn_source *source =
            s < model->source_count ? &model->source[s] : list[s - model->source_count];
        if (!source->is_on) {
            continue;
        }
        const ss_cnn_rows *held = &model->network->held;
        ss_cnn_span span = {.group_end = held->group_count};
        const ss_cnn_part part = {.count = 1, .span = &span};
        double ub, ur;
        model->kernels->scatter(held, &part, source->kap_edge, model->held_kap, model->held_b);
        model->kernels->product(held, &part, model->held_kap, NULL, model->d, model->product, &ub,
                                &ur);
        for (int32_t row = 0; row < held->row_count; ++row) {
            const ss_real *b = model->held_b + held->node[row];
            const ss_real *stretch = model->product + held->node[row];
            for (int k = 0; k < 3; ++k) {
                const double turned = model->is_held ? (double)b[k]
                                                     : model->rotation[k][0] * (double)b[0] +
                                                           model->rotation[k][1] * (double)b[1] +
                                                           model->rotation[k][2] * (double)b[2];
                out_force[k] += source->c1 * (turned + (double)stretch[k]) - source->c2 * turned;
            }
        }
    }
}

void ss_cnn_reaction(const ss_model *model, int32_t set, double out_force[3])
{
    ss_set3(out_force, 0.0, 0.0, 0.0);
    if (!model->is_ready || set < -1 || set >= model->plan.prescribed_count) {
        return;
    }
    double support[3];
    ss_cnn_active_set_fill(model);
    if (set >= 0) {
        const ss_prescribed *prescribed = model->prescribed[set].set.plan;
        for (int32_t i = 0; i < prescribed->node_count; ++i) {
            support_at(model, prescribed->node[i], model->d, model->v, support);
            for (int k = 0; k < 3; ++k) {
                out_force[k] += ss_plan_is_prescribed(prescribed, i, k) ? support[k] : 0.0;
            }
        }
        return;
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        if ((model->plan.fixed[i] & 7) == 0) {
            continue;
        }
        support_at(model, i, model->d, model->v, support);
        for (int k = 0; k < 3; ++k) {
            out_force[k] += (model->plan.fixed[i] & (1 << k)) != 0 ? support[k] : 0.0;
        }
    }
    add_held_network(model, out_force);
}
