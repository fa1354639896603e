/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * The potential of the cells, for who wants to see the network:
 *
 *   v = sum_sources a (E^ min(eps+, eps_s) + T0) sum_i w^_i ghat_i / Qhat_i
 *
 * in J, as K is: without pretension a source at its limit has v = K on its cell (of one cell). A
 * source is as strong as psi grows with its strain eps, and that is pretension too (psi =
 * E^ eps+^2 / 2 + T0 eps - T0 u.b, whose last term the body's own balance takes up): a shallow
 * dent, which shortens the edges about it, has T0 alone. At equilibrium a step tells the strength
 * on every cell, and one solve with the network's factor spreads it; in its own time (relax.h) the
 * cells have their states, and a step adds them up, which is less than a sixth of what moving them
 * on takes.
 */
#include <string.h>

/* Adds the unit source on `cell`, times `strength`. */
static void tell_cell(const ss_model *model, int32_t cell, double strength, float *out)
{
    const double scale = strength / model->network->qhat[cell];
    if (model->relax == NULL) {
        out[cell] += (float)scale;
        return;
    }
    const int32_t slot = model->relax->slot_of[cell];
    for (int32_t i = 0; slot >= 0 && i < model->node_count; ++i) {
        out[i] += (float)(scale * ss_cnn_relax_potential(model->relax, slot, i));
    }
}

static void tell_source(const ss_model *model, int32_t index, float *out)
{
    const int32_t probe = index - model->source_count;
    const ss_cnn_tool *tool = probe >= 0 ? &model->tool[probe] : NULL;
    const ss_cnn_source *source = probe >= 0 ? &tool->source : &model->source[index];
    if (!source->is_on) {
        return;
    }
    const double strength = source->c1;
    if (tool == NULL) {
        for (int32_t k = 0; k < source->cell_count; ++k) {
            tell_cell(model, source->cell[k], strength * source->cell_weight[k], out);
        }
    } else if (model->is_one_cell) {
        tell_cell(model, tool->cell.node, strength, out);
    } else {
        for (int32_t k = 0; k < tool->count; ++k) {
            tell_cell(model, tool->node[k], strength * tool->weight[k] / tool->weight_sum, out);
        }
    }
}

static void tell(const ss_model *model, float *out_source)
{
    memset(out_source, 0, (size_t)model->node_count * sizeof *out_source);
    for (int32_t k = 0; k < model->source_count + SOFTSIM_MAX_PROBES; ++k) {
        tell_source(model, k, out_source);
    }
}

static bool find(const ss_model *model, const float *source, float *out_potential)
{
    if (model->relax != NULL) {
        memcpy(out_potential, source, (size_t)model->node_count * sizeof *out_potential);
        return true;
    }
    return ss_cnn_network_spread(model->network, source, out_potential) == SOFTSIM_OK;
}

const ss_model_potential ss_cnn_potential = {.tell = tell, .find = find};
