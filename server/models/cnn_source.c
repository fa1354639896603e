/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn_energy.h"
/*
 * Where energy enters the network. One source is one current source of the network over one or
 * more cells, with weights w^_i that sum to 1 and the superposed flux densities kap = sum w^_i
 * kap_i. In displacement form, with L the Laplacian of kap, b = L P* and r = b + L u:
 *
 *   eps = u.(b + r) / 2 ( = sum_e kap_e (|P_e|^2 - L0^2) / 2 ),   eta = u.(r - b) / 2
 *   psi = E^ eps+^2 / 2 + T0 eta,   for eps > eps_s: E^ eps_s (eps - eps_s / 2) + T0 eta
 *   g   = a (dpsi/deps r + T0 (r - b)) = c1 r - c2 b
 *
 * so that one sparse product gives force and energy without cancellation. Under a tool the
 * weights follow the tissue and the tool; their change is a force too, or else a closed path over
 * soft and stiff ground gains a third of the stored energy from nowhere:
 *
 *   mu_i = a [E^ eps+ (eps_i - eps) + T0 (eta_i - eta)] / W + (da/dW) psi      ( = d(a psi)/dw_i )
 *   saturated: E^ eps_s for E^ eps+, and + a E^ (eps - eps_s)(eps_s,i - eps_s) / W
 *
 * Weights, kap, mu and f_s are taken once per sub-step, at its end (= the next one's start). While
 * a tool nears or leaves (W < W1, 0 < a < 1) the term (da/dW) psi is stiff wherever another tool or
 * an old dent has left energy: frozen over a sub-step, it feeds the tissue's motion with energy. So
 * W, a and this term are then taken at every stage, with w^ held: a potential again, and the step
 * bound knows its stiffness.
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

/* ---- set-up ------------------------------------------------------------------------------- */

softsim_status ss_cnn_source_init(const ss_model *model, ss_cnn_source *source)
{
    const size_t quads = ss_cnn_padded(model->node_count) * 4;
    const size_t edges = (size_t)model->network->edges.padded_count;
    const size_t entries = (size_t)model->network->rows.entry_count;
    source->kap_edge = ss_memory_get(edges, sizeof(ss_real));
    source->kap = ss_memory_get(entries, sizeof(ss_real));
    source->b = ss_memory_get(quads, sizeof(ss_real));
    source->r = ss_memory_get(quads, sizeof(ss_real));
    source->b_turned = model->is_held ? NULL : ss_memory_get(quads, sizeof(ss_real));
    source->eps_limit = (double)INFINITY;
    const bool is_good = source->kap_edge && source->kap && source->b && source->r &&
                         (model->is_held || source->b_turned);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}

void ss_cnn_source_fini(ss_cnn_source *source)
{
    ss_memory_free(source->kap_edge);
    ss_memory_free(source->kap);
    ss_memory_free(source->b);
    ss_memory_free(source->r);
    ss_memory_free(source->b_turned);
    *source = (ss_cnn_source){0};
}

softsim_status ss_cnn_source_fix(ss_model *model, int32_t count, const int32_t *node,
                                 const double *weight, ss_cnn_source *source)
{
    ss_cnn_network *network = model->network;
    double *kap = ss_memory_get((size_t)network->edges.padded_count, sizeof *kap);
    softsim_status status = kap ? ss_cnn_source_init(model, source) : SOFTSIM_ERROR_MEMORY;
    if (status == SOFTSIM_OK) {
        status = ss_cnn_network_superpose(network, count, node, weight, kap);
    }
    if (status == SOFTSIM_OK) {
        for (int32_t e = 0; e < network->edges.padded_count; ++e) {
            source->kap_edge[e] = (ss_real)kap[e];
        }
        model->kernels->scatter(&network->rows, &model->whole, source->kap_edge, source->kap,
                                source->b);
        for (int32_t k = 0; k < count; ++k) {
            source->qhat += weight[k] * network->qhat[node[k]];
            source->qhat_over_own += weight[k] * network->qhat[node[k]] / network->own[node[k]];
            source->inverse_own += weight[k] / network->own[node[k]];
        }
        source->amplitude = 1.0;
    }
    ss_memory_free(kap);
    return status;
}

void ss_cnn_source_moduli(ss_model *model)
{
    const ss_cnn_material *m = &model->material;
    for (int32_t k = 0; k < model->source_count; ++k) {
        ss_cnn_source *source = &model->source[k];
        source->modulus = m->is_modulus_energy ? m->modulus : m->modulus * source->qhat;
        source->eps_limit = m->saturation / m->modulus *
                            (m->is_modulus_energy ? source->qhat_over_own : source->inverse_own);
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        model->tool[k].source.modulus =
            m->is_modulus_energy ? m->modulus : m->modulus * model->network->median_qhat;
    }
}

/* ---- evaluation --------------------------------------------------------------------------- */

static void set_tensions(const ss_model *model, ss_cnn_source *source)
{
    const double stretch = fmin(fmax(source->eps, 0.0), source->eps_limit);
    source->c2 = source->amplitude * model->material.pretension;
    source->c1 = source->amplitude * source->modulus * stretch + source->c2;
    source->rank = source->eps > 0.0 && source->eps < source->eps_limit
                       ? source->amplitude * source->modulus
                       : 0.0;
}

/* b R^T of a free body: L (R P0 + t) = R L P0. */
static const ss_real *turned_b(const ss_model *model, ss_cnn_source *source)
{
    if (model->is_held) {
        return source->b;
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        const ss_real *b = source->b + 4 * (ptrdiff_t)i;
        ss_real *out = source->b_turned + 4 * (ptrdiff_t)i;
        for (int k = 0; k < 3; ++k) {
            out[k] = (ss_real)(model->rotation[k][0] * (double)b[0] +
                               model->rotation[k][1] * (double)b[1] +
                               model->rotation[k][2] * (double)b[2]);
        }
        out[3] = b[3];
    }
    return source->b_turned;
}

void ss_cnn_source_evaluate(const ss_model *model, ss_cnn_source *source, const ss_real *d)
{
    double ub, ur;
    model->kernels->product(&model->network->rows, model->part, source->kap,
                            turned_b(model, source), d, source->r, &ub, &ur);
    source->eps = 0.5 * (ub + ur) + source->far;
    source->eta = 0.5 * (ur - ub);
    set_tensions(model, source);
}

static double psi_of(const ss_model *model, const ss_cnn_source *source, double eps, double eta)
{
    const double stretch = fmin(fmax(eps, 0.0), source->eps_limit);
    const double over = eps > source->eps_limit ? eps - source->eps_limit : 0.0;
    return source->modulus * stretch * (0.5 * stretch + over) + model->material.pretension * eta;
}

double ss_cnn_source_energy(const ss_model *model, const ss_cnn_source *source)
{
    return source->amplitude * psi_of(model, source, source->eps, source->eta);
}

ss_cnn_source *ss_cnn_source_on(ss_model *model, int32_t index)
{
    ss_cnn_source *source = index < model->source_count
                                ? &model->source[index]
                                : &model->tool[index - model->source_count].source;
    return source->is_on ? source : NULL;
}

/* ---- tools -------------------------------------------------------------------------------- */

/* Strain of the edges, once for all tools; a free body's in the frame it was made in. */
static void ready_strain(ss_model *model)
{
    const ss_real *d = model->d;
    for (int32_t i = 0; !model->is_held && i < model->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            double turned_back = 0.0;
            for (int a = 0; a < 3; ++a) {
                turned_back += model->rotation[a][k] * (double)d[4 * (ptrdiff_t)i + a];
            }
            model->us[4 * (ptrdiff_t)i + k] = (ss_real)turned_back;
        }
    }
    model->kernels->strain(&model->network->edges, model->is_held ? d : model->us, model->strain,
                           model->stretch);
    model->has_strain = true;
}

/* kap = sum w^_i kap_i, and eps_i, eta_i of every touched cell, in one pass over the columns. */
static void superpose_touched(ss_model *model, ss_cnn_tool *tool)
{
    ss_cnn_network *network = model->network;
    const size_t bytes = (size_t)network->edges.padded_count * sizeof(ss_real);
    memset(tool->source.kap_edge, 0, bytes);
    for (int32_t k = 0; k < tool->count; ++k) {
        tool->share[k] = tool->weight[k] / tool->weight_sum;
        tool->eps[k] = tool->eta[k] = 0.0;
    }
    for (int32_t first = 0; first < tool->count; first += SS_CNN_CACHE_SLOTS) {
        const int32_t left = tool->count - first;
        const int32_t some = left < SS_CNN_CACHE_SLOTS ? left : SS_CNN_CACHE_SLOTS;
        ss_cnn_network_columns(network, some, tool->node + first, model->column);
        model->kernels->combine(network->edges.padded_count, some, model->column,
                                tool->share + first, model->strain, model->stretch,
                                tool->source.kap_edge, tool->eps + first, tool->eta + first);
    }
    model->kernels->scatter(&network->rows, &model->whole, tool->source.kap_edge, tool->source.kap,
                            tool->source.b);
}

/* eps_s,i: where cell i alone would saturate. */
static double cell_limit(const ss_model *model, int32_t node)
{
    const ss_cnn_material *m = &model->material;
    const double scale = m->is_modulus_energy ? model->network->qhat[node] : 1.0;
    return m->saturation * scale / (m->modulus * model->network->own[node]);
}

/* mu_i, the change of a psi with the weight of cell i. */
static void set_mu(const ss_model *model, ss_cnn_tool *tool)
{
    ss_cnn_source *source = &tool->source;
    const bool is_limited = isfinite(model->material.saturation);
    double eps = 0.0, eta = 0.0, limit = 0.0;
    for (int32_t k = 0; k < tool->count; ++k) {
        eps += tool->share[k] * tool->eps[k];
        eta += tool->share[k] * tool->eta[k];
        limit += is_limited ? tool->share[k] * cell_limit(model, tool->node[k]) : 0.0;
    }
    source->eps_limit = is_limited ? limit : (double)INFINITY;
    const double spread = source->amplitude / tool->weight_sum;
    const double tension = source->modulus * fmin(fmax(eps, 0.0), source->eps_limit);
    const double over = eps > source->eps_limit ? source->modulus * (eps - source->eps_limit) : 0.0;
    for (int32_t k = 0; k < tool->count; ++k) {
        double change =
            tension * (tool->eps[k] - eps) + model->material.pretension * (tool->eta[k] - eta);
        if (over > 0.0) {
            change += over * (cell_limit(model, tool->node[k]) - source->eps_limit);
        }
        tool->mu[k] = spread * change;
        tool->mu_largest = fmax(tool->mu_largest, fabs(tool->mu[k]));
    }
}

/* a = z^2 (3 - 2 z), z = min(1, W / W1), and da/dW. */
static void set_amplitude(ss_cnn_tool *tool)
{
    const double z = fmin(1.0, tool->weight_sum / tool->full_weight);
    tool->source.amplitude = z * z * (3.0 - 2.0 * z);
    tool->amplitude_slope = 6.0 * z * (1.0 - z) / tool->full_weight;
}

void ss_cnn_source_fade(ss_model *model, ss_cnn_tool *tool, const ss_real *u,
                        const ss_tool_pose *pose)
{
    tool->count = ss_touch_weigh(tool->touch, u, model->network->is_source, pose, &tool->node,
                                 &tool->weight, &tool->weight_sum);
    set_amplitude(tool);
}

void ss_cnn_source_add_fading(ss_model *model, ss_cnn_tool *tool)
{
    const double mu =
        tool->amplitude_slope * psi_of(model, &tool->source, tool->source.eps, tool->source.eta);
    for (int32_t k = 0; k < tool->count; ++k) {
        tool->fading_mu[k] = mu;
    }
    ss_touch_weight_forces(tool->touch, tool->fading_mu, model->force, tool->force, tool->torque);
}

double ss_cnn_source_fading_stiffness(ss_model *model, ss_cnn_tool *tool)
{
    /* d(a psi)/dW changes by |a''| psi <= 6 psi / W1^2 along dW/dP, and dW/dP itself by
     * phi'' = 2 / delta^2 over the areas of the touched cells. */
    double force[3] = {0.0}, torque[3] = {0.0};
    const double psi = fabs(psi_of(model, &tool->source, tool->source.eps, tool->source.eta));
    const double bend = 3.0 / tool->full_weight / (tool->reach * tool->reach) * psi;
    memset(tool->weight_slope, 0, (size_t)model->node_count * 4 * sizeof *tool->weight_slope);
    for (int32_t k = 0; k < tool->count; ++k) {
        tool->fading_mu[k] = 1.0;
        model->stiff[tool->node[k]] += bend * model->network->area[tool->node[k]];
    }
    ss_touch_weight_forces(tool->touch, tool->fading_mu, tool->weight_slope, force, torque);
    return 6.0 * psi / (tool->full_weight * tool->full_weight) *
           model->kernels->weighted_square(model->part, tool->weight_slope, model->mobility);
}

void ss_cnn_source_weigh(ss_model *model, ss_cnn_tool *tool, const ss_tool_pose *pose)
{
    ss_set3(tool->frozen_force, 0.0, 0.0, 0.0);
    ss_set3(tool->frozen_torque, 0.0, 0.0, 0.0);
    tool->count = ss_touch_weigh(tool->touch, model->u, model->network->is_source, pose,
                                 &tool->node, &tool->weight, &tool->weight_sum);
    tool->source.is_on = tool->count > 0 && tool->weight_sum > 0.0;
    tool->is_fading = false;
    tool->mu_largest = 0.0;
    if (!tool->source.is_on) {
        tool->count = 0;
        return;
    }
    set_amplitude(tool);
    tool->is_fading = tool->weight_sum < tool->full_weight;
    if (!model->has_strain) {
        ready_strain(model);
    }
    superpose_touched(model, tool);
    set_mu(model, tool);
    ss_touch_weight_forces(tool->touch, tool->mu, model->base, tool->frozen_force,
                           tool->frozen_torque);
}
