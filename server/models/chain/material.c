/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * Parameters into links and nodes, and the step that they allow.
 *
 * A link takes the mean of its ends' alpha and k; weights are w = k/(mean k). With no alpha given,
 * alpha = clamp(F_toe/(k mean l0), 0, 0.3): the paper sets it "according to the stiffness" and says
 * no more, so what a user knows, the force up to which tissue hardly resists, decides.
 *
 * Step (gradient flow of W with Hessian at most L/2, L the Laplacian of all links with weights w):
 * Euler decreases W from any configuration if h < 4/lambda_max(C^-1 L), and lambda_max is at most
 * max over links of s_a/C_a + s_b/C_b, s = weighted valence (Gershgorin on B C^-1 B', B the edge
 * incidence, whose spectrum is the same but for zeros). Leak adds 1/R. Saturation (R = 1) adds
 * nothing: with S = dQ/du, 0 <= S <= 1, the flow's matrix is C^-1 (H S + 1 - S), similar to
 * S^1/2 H S^1/2 + 1 - S before C^-1, at most the larger of lambda_max and 1/C. Taken is 0.9 of it.
 * Rejected: h = C, as a first reading of equation (4) suggests: it diverges as soon as s_a + s_b
 * > 4. RK4, 1.39 times the step for four times the work.
 */
#include <math.h>

#include "models/common/plan.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* Without alpha, and at most when it comes from a toe force. */
#define ALPHA_DEFAULT 0.02
#define ALPHA_MOST    0.3
/* Of the largest stable step. */
#define STEP_SHARE 0.9
const ss_param_row ss_chain_rows[SS_CHAIN_ROW_COUNT] = {
    [SS_CHAIN_ALPHA] = SS_PARAM(
        FIELD, "alpha", "slack of a link, a share of its length; default 0.02, or from toe_force_n",
        SS_FROM(0.0, 10.0), .takes_links = true, .fallback = SS_ABSENT),
    [SS_CHAIN_TOE_FORCE_N] = SS_PARAM(
        NUMBER, "toe_force_n", "instead of alpha: the tension up to which a link hardly resists",
        SS_FROM(0.0, 1e6), .fallback = SS_ABSENT),
    [SS_CHAIN_STIFFNESS_N_PER_M] =
        SS_PARAM(FIELD, "link_stiffness_n_per_m", "k, of a link beyond its slack",
                 SS_ABOVE(0.0, 1e9), .fallback = 100.0),
    [SS_CHAIN_CAPACITANCE_S] =
        SS_PARAM(FIELD, "capacitance_s",
                 "C, the time a cell takes to answer; absent: the least for which a quarter of the "
                 "time suffices, in at most 8 sub-steps a ms, the same at every rate",
                 SS_ABOVE(0.0, 1e6), .fallback = SS_ABSENT),
    [SS_CHAIN_SATURATION_SIZES] =
        SS_PARAM(NUMBER, "saturation_sizes",
                 "K, largest output of a cell in sizes of the body; absent: none",
                 SS_ABOVE(0.0, 1e6), .fallback = SS_ABSENT),
    [SS_CHAIN_SOURCE] = SS_PARAM(
        CHOICE, "source",
        "a tool holds the cells it touches, or is a current source of the displacement it asks for",
        .range.max = 1.0, .choices = "position|current"),
    [SS_CHAIN_UNLOADING] =
        SS_PARAM(CHOICE, "unloading", "as a tool goes back, alpha falls with it, at once, or not",
                 .range.max = 2.0, .choices = "ramp|literal|keep"),
    [SS_CHAIN_LEAK] = SS_PARAM(NUMBER, "leak_resistance",
                               "R_rest, draws cells back to the exact rest shape; absent: none",
                               SS_ABOVE(0.0, 1e9), .fallback = SS_ABSENT),
    [SS_CHAIN_TET_GUARD] =
        SS_PARAM(BOOL, "tet_guard", "keeps tetrahedra above a fifth of their volume",
                 SS_FROM(0, 1.0), .fallback = 1.0),
    [SS_CHAIN_CELLS] = SS_PARAM(
        INTEGER, "cells",
        "aggregates the chain elements into so many cells away from tools; absent: a cell each",
        SS_FROM(4.0, 4096.0), .fallback = SS_ABSENT),
    [SS_CHAIN_COARSE_CELLS] = SS_PARAM(
        INTEGER, "coarse_cells",
        "cells of the coarse level that spreads a poke at once; 0: none; absent: 64 for volumes",
        SS_FROM(0.0, 512.0), .fallback = SS_ABSENT)};

/* ---- links ---- */

static double mean_of(const ss_param_value *value, int32_t count)
{
    double sum = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        sum += ss_plan_node_value(value, i) / count;
    }
    return value->per_node ? sum : value->number;
}

/* alpha of links where the plan gives none. */
static double default_alpha(const ss_model *model)
{
    const double toe = model->plan.param[SS_CHAIN_TOE_FORCE_N].number;
    return isnan(toe) ? ALPHA_DEFAULT
                      : fmin(fmax(toe / (model->k * model->net->mean_length), 0.0), ALPHA_MOST);
}

static double alpha_of(const ss_param_value *alpha, int32_t a, int32_t b, double common)
{
    return alpha->is_given && !alpha->per_link
               ? 0.5 * (ss_plan_node_value(alpha, a) + ss_plan_node_value(alpha, b))
               : common;
}

/* alpha link by link: every link once, and nothing else. */
static softsim_status set_alpha_by_link(ss_model *model, softsim_error *error)
{
    const ss_param_value *alpha = &model->plan.param[SS_CHAIN_ALPHA];
    const ss_mesh *mesh = model->plan.mesh;
    ss_chain_net *net = model->net;
    uint8_t *is_set = ss_memory_get((size_t)net->group_count * SS_CHAIN_LANES, 1);
    ss_number_list none = {0}, twice = {0}, missing = {0};
    for (int32_t k = 0; is_set && k < alpha->link_count; ++k) {
        const ss_param_link *link = &alpha->per_link[k];
        int32_t p = net->first[link->node[0]];
        while (p < net->first[link->node[0] + 1] &&
               ss_chain_other(net, net->at[p], link->node[0]) != link->node[1]) {
            ++p;
        }
        if (p == net->first[link->node[0] + 1] || is_set[net->at[p]]) {
            ss_number_list_add(p == net->first[link->node[0] + 1] ? &none : &twice,
                               ss_mesh_file_node(mesh, link->node[0]));
            continue;
        }
        ss_chain_group *group = &net->group[net->at[p] / SS_CHAIN_LANES];
        const int lane = net->at[p] % SS_CHAIN_LANES;
        is_set[net->at[p]] = 1;
        group->slack[lane] = (ss_real)(link->value * (double)group->rest[lane]);
        model->has_alpha = model->has_alpha || link->value > 0.0;
    }
    for (int32_t e = 0; is_set && e < net->link_count; ++e) {
        if (!is_set[net->position[e]]) {
            ss_number_list_add(&missing, ss_mesh_file_node(mesh, net->link[e][0]));
        }
    }
    const bool is_good = none.count + twice.count + missing.count == 0;
    if (is_set && !is_good) {
        softsim_error_add(
            error, SOFTSIM_ERROR_SCENE,
            "cnn-chainmail: alpha by link: %d rows name no link (of node %s), %d name "
            "one again (of node %s), %d links have no row (of node %s): give every "
            "edge of the mesh one row",
            none.count, none.text, twice.count, twice.text, missing.count, missing.text);
    }
    const softsim_status status = !is_set   ? SOFTSIM_ERROR_MEMORY
                                  : is_good ? SOFTSIM_OK
                                            : SOFTSIM_ERROR_SCENE;
    ss_memory_free(is_set);
    return status;
}

static void set_links(ss_model *model)
{
    const ss_param_value *alpha = &model->plan.param[SS_CHAIN_ALPHA];
    const ss_param_value *k = &model->plan.param[SS_CHAIN_STIFFNESS_N_PER_M];
    const double common = default_alpha(model);
    ss_chain_net *net = model->net;
    for (int32_t e = 0; e < net->link_count; ++e) {
        const int32_t a = net->link[e][0], b = net->link[e][1];
        ss_chain_group *group = &net->group[net->position[e] / SS_CHAIN_LANES];
        const int lane = net->position[e] % SS_CHAIN_LANES;
        const double weight =
            0.5 * (ss_plan_node_value(k, a) + ss_plan_node_value(k, b)) / model->k;
        const double slack = alpha_of(alpha, a, b, common);
        group->half[lane] = (ss_real)(0.5 * weight);
        group->slack[lane] = (ss_real)(slack * (double)group->rest[lane]);
        model->has_alpha = model->has_alpha || slack > 0.0;
        model->valence[a] += weight;
        model->valence[b] += weight;
    }
}

/* ---- time ---- */

/* max over links of s_a/C_a + s_b/C_b, with C in seconds or, without, 1. */
static double link_rate(const ss_model *model)
{
    const ss_chain_net *net = model->net;
    double most = 0.0;
    for (int32_t e = 0; e < net->link_count; ++e) {
        const int32_t a = net->link[e][0], b = net->link[e][1];
        most = fmax(most, model->valence[a] * model->conductance[a] +
                              model->valence[b] * model->conductance[b]);
    }
    return most;
}

double ss_chain_stable_step(const ss_model *model)
{
    return STEP_SHARE * 2.0 / model->rate;
}

softsim_status ss_chain_material_time(ss_model *model)
{
    const ss_param_value *given = &model->plan.param[SS_CHAIN_CAPACITANCE_S];
    double largest = 0.0;
    for (int32_t i = 0; i < model->node_count; ++i) {
        model->conductance[i] = given->is_given ? 1.0 / ss_plan_node_value(given, i) : 1.0;
        largest = fmax(largest, model->conductance[i]);
    }
    model->capacitance = given->is_given ? mean_of(given, model->node_count) : 1.0;
    const double leak = model->leak * largest;
    const double drawn = isfinite(model->saturation) ? largest : 0.0;
    model->fine_rate = fmax(0.5 * link_rate(model), drawn) + leak;
    model->rate = model->fine_rate;
    if (model->coarse) {
        const double both = ss_chain_coarse_rate(model);
        if (both < 0.0) {
            return SOFTSIM_ERROR_MEMORY;
        }
        /* Sharper than the bound over links, though it has both levels in it; cells of their own
         * step as the proof over links says, and so does what has no cell that may move. */
        if (both > 0.0 && !ss_chain_is_aggregated(model)) {
            model->rate = fmax(both, drawn + leak);
        }
    }
    if (!given->is_given) {
        /* a hair more than needed, so that rounding asks for no further sub-step */
        const double c =
            1.000001 * ss_chain_planned_substep(&model->plan) / ss_chain_stable_step(model);
        for (int32_t i = 0; i < model->node_count; ++i) {
            model->conductance[i] = 1.0 / c;
        }
        model->capacitance = c;
        model->fine_rate /= c;
        model->rate /= c;
        if (ss_chain_is_aggregated(model)) {
            ss_chain_aggregated_slow(model, c);
        }
    }
    return SOFTSIM_OK;
}

/* S: twice the largest distance from the middle, which no rotation changes. */
static double size_of(const ss_mesh *mesh)
{
    double middle[3];
    return 2.0 * ss_mesh_radius(mesh, middle);
}

/* ---- all of it ---- */

static softsim_status check(const ss_model *model, softsim_error *error)
{
    const ss_model_plan *plan = &model->plan;
    const ss_param_value *param = plan->param;
    const int32_t before = error->fault_count;
    if (ss_norm3(plan->gravity) > 0.0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-chainmail: gravity_m_s2: a chain has no mass for gravity to act "
                          "on: leave it out");
    }
    if (param[SS_CHAIN_ALPHA].is_given && param[SS_CHAIN_TOE_FORCE_N].is_given) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-chainmail: alpha and toe_force_n both say how slack links are: "
                          "give one");
    }
    const bool has_cells = param[SS_CHAIN_CELLS].is_given;
    if (has_cells && param[SS_CHAIN_COARSE_CELLS].is_given &&
        param[SS_CHAIN_COARSE_CELLS].number > 0.0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-chainmail: cells and coarse_cells are two uses of the same level: "
                          "give one");
    }
    if (has_cells && param[SS_CHAIN_CELLS].number > plan->mesh->node_count) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-chainmail: cells: %.0f, but the mesh has only %d chain elements",
                          param[SS_CHAIN_CELLS].number, plan->mesh->node_count);
    }
    return error->fault_count > before ? SOFTSIM_ERROR_SCENE : SOFTSIM_OK;
}

softsim_status ss_chain_material_create(ss_model *model, softsim_error *error)
{
    const ss_param_value *param = model->plan.param;
    const size_t n = (size_t)model->node_count;
    model->conductance = ss_arena_get(&model->arena, n, sizeof *model->conductance);
    model->valence = ss_arena_get(&model->arena, n, sizeof *model->valence);
    if (!model->conductance || !model->valence) {
        return SOFTSIM_ERROR_MEMORY;
    }
    if (check(model, error) != SOFTSIM_OK) {
        return SOFTSIM_ERROR_SCENE;
    }
    model->k = mean_of(&param[SS_CHAIN_STIFFNESS_N_PER_M], model->node_count);
    const double resistance = param[SS_CHAIN_LEAK].number;
    model->leak = param[SS_CHAIN_LEAK].is_given ? 1.0 / resistance : 0.0;
    const double sizes = param[SS_CHAIN_SATURATION_SIZES].number;
    model->saturation = param[SS_CHAIN_SATURATION_SIZES].is_given
                            ? sizes * size_of(model->plan.mesh)
                            : (double)INFINITY;
    model->unloading = (ss_chain_unloading)param[SS_CHAIN_UNLOADING].number;
    model->is_current = param[SS_CHAIN_SOURCE].number != 0.0;
    set_links(model);
    return param[SS_CHAIN_ALPHA].per_link ? set_alpha_by_link(model, error) : SOFTSIM_OK;
}
