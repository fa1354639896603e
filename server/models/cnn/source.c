/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
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
 * soft and stiff ground gains a third of the stored spurious energy:
 *
 *   mu_i = a [E^ eps+ (eps_i - eps) + T0 (eta_i - eta)] / W + (da/dW) (psi - psi_0)
 *   saturated: E^ eps_s for E^ eps+, and + a E^ (eps - eps_s)(eps_s,i - eps_s) / W
 *
 * The source's energy is a (psi - psi_0). psi_0 follows psi while the tool barely touches (a below
 * a quarter, the closer the smaller a) and then stays, so that a tool that begins to touch meets
 * only what it strains itself. With psi_0 = 0 a tool near tissue that is strained already (by
 * another tool, by its own old dent) faces a barrier of energy psi, higher than what denting the
 * tissue costs: the tissue retreats before the tool, a stays near 0, psi grows the more, and the
 * tool presses through the forces of its weights alone: a second equilibrium, at a fifth of the
 * force and a tenth of the stable step. A tool that is put there at once, as after a pause, begins
 * with psi_0 = psi however far it is in: with 0, what a dent stored (377 mJ in the end, by a tool
 * put into a kidney every 38 ms) came anew with every touch. psi_0 never exceeds psi, so that a
 * tool never sticks. What a change of psi_0 takes from the energy is booked as dissipated, what it
 * gives as work, which goes out of the motion again (spring.c).
 *
 * Weights, kap, mu and f_s are taken once per sub-step, at its end (= the next one's start). While
 * a tool nears or leaves (W < W1, 0 < a < 1) the term of da/dW is stiff: frozen over a sub-step, it
 * feeds the tissue's motion with energy. So
 * W, a and this term are then taken at every stage, with w^ held: a potential again, and the step
 * bound knows its stiffness.
 *
 * A grasp holds its nodes, and so its cells: their weights w~, W and a stay as they were when it
 * was taken, and with them psi_0, which then is a constant. For fixed weights Pi is convex, so that
 * tissue that is drawn has one place and gives back what it took. Its springs take over f_s as
 * those were, in the tool's frame (a first order of the weights' change about that moment), and the
 * reaction does not jump. As a grasp that was let go fades, w = fade w~ + (1 - fade) w(P, X); what
 * that changes of the energy, from one preparation to another, is booked as a change of psi_0 is.
 * Rejected: its slope at the sub-step's end: where the tissue has left the tool a falls to 0 within
 * a few sub-steps, and 5 % of what was stored was not booked. Rejected: weights that follow in a
 * grasp too. A tool from which tissue is drawn leaves it: a falls to the quarter below which psi_0
 * follows psi, psi_0 rises at small a and falls at large a, and a cone in a kidney gave 12 mJ to
 * the hand in every turn of 12 mm out, 10 mm aside and back (19 mJ were stored); held still, it
 * jumped between two places, of 2.7 and 5.5 N. With psi_0 alone held nothing is gained, but the
 * tissue leaves the tool all the same: 2.8 N on the way out, 0.45 N at its end.
 *
 * `source: contact` is the paper's literal reading (Zhong et al. 2006, equation 10): one contact
 * cell carries the whole source and every other cell none, w^ = 1 there, mu_i = (da/dW) (psi -
 * psi_0). It is the cell of largest weight under the tool, chosen again between sub-steps while the
 * tool only nears (the energy of a change is booked as work; tissue at rest has none), and kept
 * from the first sub-step that ends with the tool pressed in, or from a grasp, until it lets go
 * (W = 0), jumps or disappears: a cell that followed the tool would be the nearest node that jumps,
 * with the force. The price: the source stays behind a tool that slides. Further than its reach
 * from the cell the tool feels little but ks, and the network goes on pulling where the touch
 * began. Use it for pokes and for the paper's figures, footprints for hands.
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

/* a of a tool that barely touches. */
#define BARELY 0.25
/* Of a load's modulus: energies below are rounding. */
#define ROUNDING_SHARE 1e-6

/* ---- set-up ---- */

softsim_status ss_cnn_source_init(ss_model *model, ss_cnn_source *source)
{
    const size_t quads = ss_cnn_padded(model->node_count) * 4;
    const size_t edges = (size_t)model->network->edges.padded_count;
    const size_t entries = (size_t)model->network->rows.entry_count;
    ss_arena *arena = &model->arena;
    SS_ARENA_TAKE(arena, SS_ROOM(edges, source->kap_edge), SS_ROOM(entries, source->kap),
                  SS_ROOM(quads, source->b), SS_ROOM(quads, source->r));
    source->b_turned = model->is_held ? NULL : ss_arena_get(arena, quads, sizeof(ss_real));
    source->eps_limit = (double)INFINITY;
    return ss_arena_status(arena);
}

softsim_status ss_cnn_source_fix(ss_model *model, int32_t count, const int32_t *node,
                                 const double *weight, ss_cnn_source *source)
{
    ss_cnn_network *network = model->network;
    double *kap = ss_memory_get((size_t)network->edges.padded_count, sizeof *kap);
    source->cell = ss_arena_get(&model->arena, (size_t)count, sizeof *source->cell);
    source->cell_weight = ss_arena_get(&model->arena, (size_t)count, sizeof *source->cell_weight);
    softsim_status status = kap ? ss_cnn_source_init(model, source) : SOFTSIM_ERROR_MEMORY;
    if (status == SOFTSIM_OK) {
        source->cell_count = count;
        memcpy(source->cell, node, (size_t)count * sizeof *node);
        memcpy(source->cell_weight, weight, (size_t)count * sizeof *weight);
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
    double largest = 0.0; /* J, of the loads */
    const bool has_tool = ss_plan_tool_count(&model->plan) > 0;
    for (int32_t k = 0; k < model->source_count; ++k) {
        ss_cnn_source *source = &model->source[k];
        source->modulus = m->is_modulus_energy ? m->modulus : m->modulus * source->qhat;
        largest = fmax(largest, source->modulus);
        source->eps_limit = m->saturation / m->modulus *
                            (m->is_modulus_energy ? source->qhat_over_own : source->inverse_own);
        if (model->saturation) { /* alone it saturates cell by cell, not at their mean potential */
            model->saturation->potential[k][k] =
                m->saturation / (source->modulus * source->eps_limit);
        }
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        model->tool[k].source.modulus =
            m->is_modulus_energy ? m->modulus : m->modulus * model->network->median_qhat;
    }
    if (!has_tool && largest > 0.0) { /* no hand to feel it: what rounding makes of the strain */
        model->small_energy = ROUNDING_SHARE * largest;
    }
}

/* ---- evaluation ---- */

void ss_cnn_source_set_stretch(const ss_model *model, ss_cnn_source *source, double stretch,
                               bool is_free)
{
    source->stretch = stretch;
    source->c2 = source->amplitude * model->material.pretension;
    source->c1 = source->amplitude * source->modulus * stretch + source->c2;
    source->strain_modulus = is_free ? source->amplitude * source->modulus : 0.0;
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

/* The held cells' part of d.b and d.r. They have no rows in the product, and none is missing where
 * they are at their place; but the rest place of a body that is held at a hinge turns away from
 * them. */
static void add_held_cells(const ss_model *model, const ss_cnn_source *source, const ss_real *d,
                           double *ub, double *ur)
{
    const ss_cnn_rows *held = &model->network->held;
    for (int32_t g = 0; g < held->group_count; ++g) {
        const ss_cnn_group *group = &held->group[g];
        for (int32_t k = 0; k < group->row_count * group->degree; ++k) {
            const int32_t entry = group->first_entry + k;
            const ss_real *arm = held->arm + 4 * (ptrdiff_t)entry;
            const ss_real *here = d + held->node[group->first_row + k / group->degree];
            const ss_real *there = d + held->neighbour[entry];
            const double kap = (double)source->kap_edge[held->edge[entry]];
            for (int a = 0; a < 3; ++a) {
                const double rest = model->rotation[a][0] * (double)arm[0] +
                                    model->rotation[a][1] * (double)arm[1] +
                                    model->rotation[a][2] * (double)arm[2];
                const double change = (double)here[a] - (double)there[a];
                *ub += kap * (double)here[a] * rest;
                *ur += kap * (double)here[a] * (rest + change);
            }
        }
    }
}

void ss_cnn_source_evaluate(const ss_model *model, ss_cnn_source *source, const ss_real *d)
{
    double ub, ur;
    model->kernels->product(&model->network->rows, model->part, source->kap,
                            turned_b(model, source), d, source->r, &ub, &ur);
    if (!model->is_held) {
        add_held_cells(model, source, d, &ub, &ur);
    }
    source->eps = 0.5 * (ub + ur) + source->far;
    source->eta = 0.5 * (ur - ub);
    ss_cnn_source_set_stretch(model, source, fmin(fmax(source->eps, 0.0), source->eps_limit),
                              source->eps > 0.0 && source->eps < source->eps_limit);
}

/* psi at the last evaluation. */
static double psi_of(const ss_model *model, const ss_cnn_source *source)
{
    return source->modulus * source->stretch * (source->eps - 0.5 * source->stretch) +
           model->material.pretension * source->eta;
}

double ss_cnn_source_energy(const ss_model *model, const ss_cnn_source *source)
{
    return source->amplitude * (psi_of(model, source) - source->reference);
}

ss_cnn_source *ss_cnn_source_on(ss_model *model, int32_t index)
{
    ss_cnn_source *source = index < model->source_count
                                ? &model->source[index]
                                : &model->tool[index - model->source_count].source;
    return source->is_on ? source : NULL;
}

/* ---- tools ---- */

/* What of a tool's weights follows tissue and tool: nothing in a grasp. */
static double loose_share(const ss_cnn_tool *tool)
{
    const ss_grasp *grasp = &tool->base->grasp;
    return grasp->count > 0 ? 1.0 - grasp->fade : 1.0;
}

/* The loose share of the weights that tissue and tool have now, and what the grasp holds. */
static void add_held_weights(ss_cnn_tool *tool, int32_t count, const int32_t *node,
                             const double *weight)
{
    const ss_grasp *grasp = &tool->base->grasp;
    const double loose = 1.0 - grasp->fade;
    int32_t end = count, k = 0;
    for (int32_t i = 0; i < count; ++i) {
        tool->own_node[i] = node[i];
        tool->own_weight[i] = loose * weight[i];
    }
    for (int32_t i = 0; i < grasp->count; ++i) {
        while (k < count && node[k] < grasp->node[i]) {
            ++k;
        }
        const bool is_near = k < count && node[k] == grasp->node[i];
        const int32_t at = is_near ? k : end++;
        const double held =
            grasp->stiffness[i] / (SS_GRASP_STIFFNESS_RATIO * tool->base->stiffness);
        tool->own_node[at] = grasp->node[i];
        tool->own_weight[at] = (is_near ? loose * weight[k] : 0.0) + grasp->fade * held;
    }
    tool->count = end;
    tool->node = tool->own_node;
    tool->weight = tool->own_weight;
    tool->weight_sum = 0.0;
    for (int32_t i = 0; i < end; ++i) {
        tool->weight_sum += tool->own_weight[i];
    }
}

/* The weights with the tool at `pose`, and the amplitude, z^2 (3 - 2 z) with z = min(1, W / W1). */
static void take_weights(ss_model *model, ss_cnn_tool *tool, const ss_real *u,
                         const ss_tool_pose *pose)
{
    tool->count = 0;
    if (loose_share(tool) > 0.0) {
        tool->count = ss_contact_query_weigh(tool->base->query, u, model->network->is_source, pose,
                                             &tool->node, &tool->weight, &tool->weight_sum);
    }
    if (tool->base->grasp.count > 0) {
        add_held_weights(tool, tool->count, tool->node, tool->weight);
    }
    const double z = fmin(1.0, tool->weight_sum / tool->full_weight);
    tool->source.amplitude = z * z * (3.0 - 2.0 * z);
    tool->amplitude_slope = 6.0 * z * (1.0 - z) / tool->full_weight;
}

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

/* Columns of at most SS_CNN_CACHE_SLOTS cells into model->column: settled, or as far as they are.
 */
static void ready_influence(ss_model *model, int32_t count, const int32_t *node)
{
    if (model->relax) {
        ss_cnn_relax_influence(model->relax, count, node, model->column);
    } else {
        ss_cnn_network_influence(model->network, count, node, model->column);
    }
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
        ready_influence(model, some, tool->node + first);
        model->kernels->combine(network->edges.padded_count, some, model->column,
                                tool->share + first, model->strain, model->stretch,
                                tool->source.kap_edge, tool->eps + first, tool->eta + first);
    }
    model->kernels->scatter(&network->rows, &model->whole, tool->source.kap_edge, tool->source.kap,
                            tool->source.b);
}

/* kap of a source of fixed weights. */
static void superpose_fixed(ss_model *model, ss_cnn_source *source)
{
    const ss_cnn_network *network = model->network;
    const int32_t padded = network->edges.padded_count;
    memset(source->kap_edge, 0, (size_t)padded * sizeof *source->kap_edge);
    for (int32_t k = 0; k < source->cell_count; ++k) {
        const ss_real weight = (ss_real)source->cell_weight[k];
        ready_influence(model, 1, &source->cell[k]);
        const ss_real *column = model->column[0];
        for (int32_t e = 0; e < padded; ++e) {
            source->kap_edge[e] += weight * column[e];
        }
    }
    model->kernels->scatter(&network->rows, &model->whole, source->kap_edge, source->kap,
                            source->b);
}

void ss_cnn_source_relax(ss_model *model)
{
    if (!model->relax) {
        return;
    }
    ss_cnn_relax_look(model->relax);
    for (int32_t k = 0; k < model->source_count; ++k) {
        if (model->source[k].is_on) {
            superpose_fixed(model, &model->source[k]);
        }
    }
}

/* eps_s,i: where cell i alone would saturate. */
static double cell_limit(const ss_model *model, int32_t node)
{
    const ss_cnn_material *m = &model->material;
    const double scale = m->is_modulus_energy ? model->network->qhat[node] : 1.0;
    return m->saturation * scale / (m->modulus * model->network->own[node]);
}

void ss_cnn_source_book(ss_model *model, ss_cnn_source *source, double lost)
{
    model->dissipated += fmax(lost, 0.0);
    model->work += fmax(-lost, 0.0);
    source->given += fmax(-lost, 0.0);
}

/* psi_0 for the weights just taken. */
static void set_reference(ss_model *model, ss_cnn_tool *tool, double psi)
{
    ss_cnn_source *source = &tool->source;
    if (!(loose_share(tool) > 0.0)) {
        return;
    }
    if (source->is_placed) {
        source->reference = psi;
        return;
    }
    const double loose = fmax(0.0, 1.0 - source->amplitude / BARELY);
    const double before = source->reference;
    source->reference = fmin(psi, before + loose * loose * (psi - before));
    ss_cnn_source_book(model, source, source->amplitude * (source->reference - before));
}

/* mu_i, the change of a psi with the weight of cell i. */
static void set_mu(ss_model *model, ss_cnn_tool *tool)
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
    const double spread = source->amplitude / tool->weight_sum, loose = loose_share(tool);
    const double stretch = fmin(fmax(eps, 0.0), source->eps_limit);
    const double tension = source->modulus * stretch;
    set_reference(model, tool, tension * (eps - 0.5 * stretch) + model->material.pretension * eta);
    const double over = eps > source->eps_limit ? source->modulus * (eps - source->eps_limit) : 0.0;
    for (int32_t k = 0; k < tool->count; ++k) {
        double change =
            tension * (tool->eps[k] - eps) + model->material.pretension * (tool->eta[k] - eta);
        if (over > 0.0) {
            change += over * (cell_limit(model, tool->node[k]) - source->eps_limit);
        }
        tool->mu[k] = spread * change;
        tool->mu_largest = fmax(tool->mu_largest, loose * fabs(tool->mu[k]));
    }
}

void ss_cnn_source_fade(ss_model *model, ss_cnn_tool *tool, const ss_real *u,
                        const ss_tool_pose *pose)
{
    take_weights(model, tool, u, pose);
}

/* (da/dW) (psi - psi_0), psi at the last evaluation. */
static double amplitude_mu(const ss_model *model, const ss_cnn_tool *tool)
{
    return tool->amplitude_slope * (psi_of(model, &tool->source) - tool->source.reference);
}

void ss_cnn_source_add_fading(ss_model *model, ss_cnn_tool *tool)
{
    const double mu = loose_share(tool) * amplitude_mu(model, tool);
    for (int32_t k = 0; k < tool->count; ++k) {
        tool->fading_mu[k] = mu;
    }
    ss_contact_query_weight_forces(tool->base->query, tool->fading_mu, model->force,
                                   tool->base->force, tool->base->torque);
}

double ss_cnn_source_fading_stiffness(ss_model *model, ss_cnn_tool *tool)
{
    /* d(a psi)/dW changes by |a''| psi <= 6 psi / W1^2 along dW/dP, and dW/dP itself by
     * phi'' = 2 / delta^2 over the areas of the touched cells. psi, not psi - psi_0: within a
     * sub-step a may grow beyond where psi_0 still follows. */
    double force[3] = {0.0}, torque[3] = {0.0};
    const ss_cnn_source *source = &tool->source;
    const double psi = fabs(psi_of(model, source));
    const double bend = 3.0 / tool->full_weight / (tool->base->delta * tool->base->delta) * psi;
    memset(tool->weight_slope, 0, (size_t)model->node_count * 4 * sizeof *tool->weight_slope);
    for (int32_t k = 0; k < tool->count; ++k) {
        tool->fading_mu[k] = 1.0;
        model->stiff[tool->node[k]] += bend * model->network->surface_area[tool->node[k]];
    }
    ss_contact_query_weight_forces(tool->base->query, tool->fading_mu, tool->weight_slope, force,
                                   torque);
    return 6.0 * psi / (tool->full_weight * tool->full_weight) *
           model->kernels->weighted_square(model->part, tool->weight_slope, model->mobility);
}

const ss_real *ss_cnn_source_weight_forces(ss_model *model, ss_cnn_tool *tool)
{
    double force[3] = {0.0}, torque[3] = {0.0};
    const double mu = tool->is_fading ? amplitude_mu(model, tool) : 0.0;
    memset(tool->weight_slope, 0, (size_t)model->node_count * 4 * sizeof *tool->weight_slope);
    for (int32_t k = 0; k < tool->count; ++k) {
        tool->fading_mu[k] = tool->mu[k] + mu;
    }
    ss_contact_query_weight_forces(tool->base->query, tool->fading_mu, tool->weight_slope, force,
                                   torque);
    return tool->weight_slope;
}

void ss_cnn_source_end_contact(ss_cnn_tool *tool)
{
    tool->cell = (ss_cnn_contact_cell){.node = -1};
    tool->source.reference = 0.0;
}

void ss_cnn_source_keep(ss_model *model)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        model->tool[k].cell_before = model->tool[k].cell;
        model->tool[k].reference_before = model->tool[k].source.reference;
        model->tool[k].given_before = model->tool[k].source.given;
        model->tool[k].penalty_before = model->tools.tool[k].penalty;
    }
}

void ss_cnn_source_restore(ss_model *model)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        model->tool[k].cell = model->tool[k].cell_before;
        model->tool[k].source.reference = model->tool[k].reference_before;
        model->tool[k].source.given = model->tool[k].given_before;
        model->tools.tool[k].penalty = model->tool[k].penalty_before;
    }
}

/* kap of one cell. */
static void take_cell(ss_model *model, ss_cnn_tool *tool, int32_t node)
{
    const ss_cnn_network *network = model->network;
    ready_influence(model, 1, &node);
    memcpy(tool->source.kap_edge, model->column[0],
           (size_t)network->edges.padded_count * sizeof *tool->source.kap_edge);
    model->kernels->scatter(&network->rows, &model->whole, tool->source.kap_edge, tool->source.kap,
                            tool->source.b);
    tool->source.eps_limit =
        isfinite(model->material.saturation) ? cell_limit(model, node) : (double)INFINITY;
}

/* The contact cell: kept once the tool has pressed on it or grasps, until then the one of largest
 * weight. */
static void weigh_one_cell(ss_model *model, ss_cnn_tool *tool)
{
    ss_cnn_contact_cell *cell = &tool->cell;
    cell->has_pressed = cell->node >= 0 && (cell->has_pressed || tool->base->penalty > 0.0 ||
                                            tool->base->grasp.count > 0);
    int32_t best = 0;
    for (int32_t k = 1; k < tool->count; ++k) {
        best = tool->weight[k] > tool->weight[best] ? k : best;
    }
    const int32_t node = cell->has_pressed ? cell->node : tool->node[best];
    const bool is_moved = cell->node >= 0 && node != cell->node;
    double before = 0.0;
    if (is_moved) {
        ss_cnn_source_evaluate(model, &tool->source, model->d);
        before = ss_cnn_source_energy(model, &tool->source);
    }
    cell->node = node;
    take_cell(model, tool, node);
    ss_cnn_source_evaluate(model, &tool->source, model->d);
    const double change = is_moved ? ss_cnn_source_energy(model, &tool->source) - before : 0.0;
    model->work += change;
    tool->source.given += fmax(change, 0.0);
    set_reference(model, tool, psi_of(model, &tool->source));
}

void ss_cnn_source_weigh(ss_model *model, ss_cnn_tool *tool, const ss_tool_pose *pose)
{
    ss_set3(tool->frozen_force, 0.0, 0.0, 0.0);
    ss_set3(tool->frozen_torque, 0.0, 0.0, 0.0);
    take_weights(model, tool, model->u, pose);
    tool->source.is_on = tool->count > 0 && tool->weight_sum > 0.0;
    tool->is_fading = false;
    tool->mu_largest = 0.0;
    if (!tool->source.is_on) {
        tool->count = 0;
        ss_cnn_source_end_contact(tool);
        tool->source.is_placed = false;
        return;
    }
    const double loose = loose_share(tool);
    tool->is_fading = loose > 0.0 && tool->weight_sum < tool->full_weight;
    if (model->is_one_cell) {
        weigh_one_cell(model, tool);
        tool->source.is_placed = false;
        return;
    }
    if (!model->has_strain) {
        ready_strain(model);
    }
    superpose_touched(model, tool);
    set_mu(model, tool);
    tool->source.is_placed = false;
    for (int32_t k = 0; k < tool->count; ++k) {
        tool->fading_mu[k] = loose * tool->mu[k];
    }
    if (loose > 0.0) {
        ss_contact_query_weight_forces(tool->base->query, tool->fading_mu, model->base,
                                       tool->frozen_force, tool->frozen_torque);
    }
}
