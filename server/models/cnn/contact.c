/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * What the hand is told of a contact: force, place, and how stiff the tissue feels.
 *
 * The tissue's static tangent at the tool, along the contact's normal n, is the contact's own
 * stiffness in series with the body. With c the force on the nodes and k_cc that on the tool for
 * a unit motion of the tool along n, and H the body's static tangent
 *
 *   H = ks + sum_k [ c1_k L_k + m_k r_k r_k' ] + (B/V0) N N'
 *        + kc sum_q A_q c'(d_q) B_q n_q n_q' B_q' + k
 *
 * (weights held, L_k the Laplacian of kap_k, m_k its strain_modulus; c as contact/query.c has it;
 * k: grasp springs), any motion y of the nodes gives
 *
 *   k(y) = k_cc - 2 c.y + y.H y  >=  k_cc - c.H^-1 c
 *
 * with equality at H y = c. y is kept between steps and improved by a fixed small number of
 * Jacobi-preconditioned conjugate gradients, so that the estimate costs a few products, depends
 * on nothing but the past, and errs high: a stiffness that is too low makes the haptic loop
 * unstable, one that is too high only stiffens it. Rejected: an exact solve (a factor a step),
 * the secant force over depth (too low), a fit of force to motion (late, and blind in slides).
 *
 * Tangentially the body answers with the same ks and the same tensions: k_t = k_n, which errs
 * high by the strain term, and by the pressure's.
 * The viscosity is the damping that the motion y meets, y.gamma y, at most 10 ms of stiffness.
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

/* Conjugate gradients per step, and in the first step of a contact. */
enum { ITERATIONS = 2, FIRST_ITERATIONS = 12, REST_ITERATIONS = 300 };
/* s: viscosity over stiffness. */
#define MAX_VISCOUS_TIME 0.01

/* ---- the static tangent ---- */

/* out = H x; returns x.out. */
static double apply_tangent(ss_model *model, const ss_real *x, ss_real *out)
{
    const ss_cnn_kernels *kernels = model->kernels;
    const ss_cnn_part *part = model->part;
    memset(out, 0, (size_t)model->node_count * 4 * sizeof *out);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) { /* minus the contact's part */
        if (model->tools.tool[k].is_present) {
            ss_tool_add_change(&model->tools.tool[k], x, out);
        }
    }
    double square = 0.0;
    const ss_cnn_source *first = NULL;
    for (int32_t k = 0; k < model->source_count + SOFTSIM_MAX_PROBES; ++k) {
        const ss_cnn_source *source = ss_cnn_source_on(model, k);
        if (!source || source->c1 == 0.0) {
            continue;
        }
        double unused, stretch;
        ss_real *lx = first ? model->vs[0] : model->us;
        kernels->product(&model->network->rows, part, source->kap, NULL, x, lx, &unused, &stretch);
        if (first) {
            kernels->axpy(part, -source->c1, lx, out);
        }
        first = first ? first : source;
    }
    square += kernels->tangent(part, model->rest_stiffness, x, first ? first->c1 : 0.0,
                               first ? model->us : NULL, out);
    for (int32_t k = 0; k < model->source_count + SOFTSIM_MAX_PROBES; ++k) {
        const ss_cnn_source *source = ss_cnn_source_on(model, k);
        if (source && source->strain_modulus > 0.0) {
            const double along = kernels->dot(part, source->r, x);
            kernels->axpy(part, source->strain_modulus * along, source->r, out);
            square += source->strain_modulus * along * along;
        }
    }
    return square + ss_cnn_enclosed_tangent(model, x, out);
}

/* Rows of the Jacobi preconditioner, from the step bound's: 0 on axes that cannot move. */
static void set_inverse(ss_model *model)
{
    for (int32_t i = 0; i < model->node_count; ++i) {
        const ss_real inverse =
            model->stiff[i] > 0.0 ? (ss_real)(1.0 / model->stiff[i]) : (ss_real)1;
        const ptrdiff_t at = 4 * (ptrdiff_t)i;
        for (int k = 0; k < 4; ++k) {
            model->inverse[at + k] = model->mobility[at + k] > 0 ? inverse : 0;
        }
    }
}

/* Improves y towards H y = push; leaves the residual push - H y in model->residual. */
static void solve_some(ss_model *model, ss_real *y, int iterations)
{
    const ss_cnn_kernels *kernels = model->kernels;
    const ss_cnn_part *part = model->part;
    const size_t bytes = (size_t)model->node_count * 4 * sizeof *y;
    (void)apply_tangent(model, y, model->product);
    memcpy(model->residual, model->push, bytes);
    double rho = kernels->descend(part, 1.0, model->product, model->product, model->inverse,
                                  model->scaled, model->residual, model->search);
    /* Beyond the precision of the scalars there is nothing left to improve. */
    const double enough = rho * (sizeof *y == sizeof(float) ? 1e-13 : 1e-26);
    for (int k = 0; k < iterations && rho > enough; ++k) {
        const double curvature = apply_tangent(model, model->search, model->product);
        if (!(curvature > 0.0)) {
            break;
        }
        const double next = kernels->descend(part, rho / curvature, model->search, model->product,
                                             model->inverse, y, model->residual, model->scaled);
        if (k + 1 < iterations) { /* the next direction */
            kernels->axpy(part, next / rho, model->search, model->scaled);
            ss_real *t = model->search;
            model->search = model->scaled;
            model->scaled = t;
        }
        rho = next;
    }
}

/* ---- in contact ---- */

/* sum gamma |y|^2 */
static double damping_met(const ss_model *model, const ss_real *y)
{
    ss_cnn_totals totals;
    model->kernels->total(model->part, y, y, model->rest_stiffness, model->damping, &totals);
    return totals.kinetic;
}

/* Fills tool->base->felt for a push along `normal`; returns the viscosity. out_own: the contact's
 * stiffness alone. */
static double feel(ss_model *model, ss_cnn_tool *tool, const double normal[3], double *out_own)
{
    const ss_cnn_part *part = model->part;
    memset(model->push, 0, (size_t)model->node_count * 4 * sizeof(ss_real));
    const double k_cc = *out_own = ss_tool_push(tool->base, normal, model->push);
    set_inverse(model);
    if (!tool->base->was_touching) {
        memset(tool->shape_y, 0, (size_t)model->node_count * 4 * sizeof(ss_real));
    }
    solve_some(model, tool->shape_y, tool->base->was_touching ? ITERATIONS : FIRST_ITERATIONS);
    /* H y = c - residual, hence k(y) = k_cc - y.(c + residual). */
    const double felt = k_cc - model->kernels->dot(part, tool->shape_y, model->push) -
                        model->kernels->dot(part, tool->shape_y, model->residual);
    ss_tool_set_felt(tool->base, isfinite(felt) && felt > 0.0 ? felt : k_cc, k_cc);
    const double viscosity = tool->base->was_touching ? damping_met(model, tool->shape_y) : 0.0;
    return fmin(viscosity, MAX_VISCOUS_TIME * tool->base->felt);
}

/* The contacts are the samples' alone. The forces through the weights push the tool too: most of
 * them across the contacts, where the tissue is soft on one side, as at a thin edge. */
static void set_other_force(const double origin[3], ss_contact_set *set)
{
    ss_sub3(set->other_force, set->force, set->friction);
    ss_sub3(set->other_torque, set->torque, set->friction_torque);
    for (int32_t k = 0; k < set->count; ++k) {
        const ss_contact *contact = &set->contact[k];
        double arm[3], force[3], torque[3];
        ss_scale3(force, contact->normal, contact->force);
        ss_sub3(arm, contact->point, origin);
        ss_cross3(torque, arm, force);
        ss_sub3(set->other_force, set->other_force, force);
        ss_sub3(set->other_torque, set->other_torque, torque);
    }
}

void ss_cnn_contacts(ss_model *model, int32_t probe, double near, ss_contact_set *out)
{
    ss_tool *tool = ss_tools_find(&model->tools, probe, out);
    if (!tool || !model->is_ready) {
        return;
    }
    double along[3];
    ss_surface_refit(model->tools.surface, model->u);
    if (ss_tool_fill_contacts(tool, model->u, near, out, along)) {
        const double viscosity = feel(model, &model->tool[probe], along, &out->step_stiffness);
        ss_contact_set_share(out, tool->felt, viscosity);
        if (!out->is_held) {
            set_other_force(tool->pose.position, out);
        }
    }
    tool->was_touching = ss_tool_is_touching(tool);
}

/* ---- at rest ---- */

/* The cell whose Qhat is the median's nearest: neither at the rim nor a special place. */
static int32_t usual_cell(const ss_cnn_network *network)
{
    int32_t best = -1;
    for (int32_t i = 0; i < network->node_count; ++i) {
        if (network->is_source[i] &&
            (best < 0 || fabs(network->qhat[i] - network->median_qhat) <
                             fabs(network->qhat[best] - network->median_qhat))) {
            best = i;
        }
    }
    return best;
}

/* The push of a contact sample at cell `i` by the subdivision row's weights: half on the node,
 * half on its ring, along the node's normal. Returns false where the node has no normal. */
static bool push_cell(ss_model *model, int32_t cell)
{
    const ss_mesh *mesh = model->plan.mesh;
    const ss_cnn_edges *edges = &model->network->edges;
    double normal[3];
    int32_t degree = 0;
    if (ss_mesh_node_normal(mesh, cell, normal) == 0) {
        return false;
    }
    for (int32_t e = 0; e < edges->count; ++e) {
        degree += edges->from[e] == 4 * cell || edges->to[e] == 4 * cell;
    }
    memset(model->push, 0, (size_t)model->node_count * 4 * sizeof(ss_real));
    for (int k = 0; k < 3; ++k) {
        model->push[4 * (ptrdiff_t)cell + k] = (ss_real)(0.5 * normal[k]);
        for (int32_t e = 0; e < edges->count; ++e) {
            const bool is_from = edges->from[e] == 4 * cell, is_to = edges->to[e] == 4 * cell;
            if (is_from || is_to) {
                const int32_t other = is_from ? edges->to[e] : edges->from[e];
                model->push[other + k] = (ss_real)(0.5 / degree * normal[k]);
            }
        }
    }
    return true;
}

/* 1 / stiffness of the body for a push at the cell of the column `kap`, at rest, with the
 * pretension that it has once the network has settled. */
static double rest_compliance(ss_model *model, ss_cnn_tool *tool, const double *kap)
{
    ss_cnn_source *source = &tool->source;
    for (int32_t e = 0; e < model->network->edges.padded_count; ++e) {
        source->kap_edge[e] = (ss_real)kap[e];
    }
    model->kernels->scatter(&model->network->rows, &model->whole, source->kap_edge, source->kap,
                            source->b);
    source->c1 = source->c2 = model->material.pretension;
    source->strain_modulus = 0.0;
    source->is_on = true;
    ss_cnn_set_bound(model);
    set_inverse(model);
    memset(tool->shape_y, 0, (size_t)model->node_count * 4 * sizeof(ss_real));
    solve_some(model, tool->shape_y, REST_ITERATIONS);
    source->is_on = false;
    return model->kernels->dot(model->part, tool->shape_y, model->push);
}

softsim_status ss_cnn_set_rest_felt(ss_model *model)
{
    if (!model->tools.surface) {
        return SOFTSIM_OK;
    }
    const double one = 1.0;
    const int32_t cell = usual_cell(model->network);
    double *kap = ss_memory_get((size_t)model->network->edges.padded_count, sizeof *kap);
    const softsim_status status =
        !kap       ? SOFTSIM_ERROR_MEMORY
        : cell < 0 ? SOFTSIM_OK
                   : ss_cnn_network_superpose(model->network, 1, &cell, &one, kap);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_cnn_tool *tool = &model->tool[k];
        if (!tool->base->is_used || status != SOFTSIM_OK) {
            continue;
        }
        const bool is_pushed = cell >= 0 && push_cell(model, cell);
        ss_tool_set_rest_felt(tool->base, is_pushed ? rest_compliance(model, tool, kap) : 0.0);
        memset(tool->shape_y, 0, (size_t)model->node_count * 4 * sizeof(ss_real));
    }
    ss_memory_free(kap);
    return status;
}
