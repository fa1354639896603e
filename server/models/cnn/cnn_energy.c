/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * cnn-energy: a surface or a volume deforms as a cellular neural network spreads the energy of a
 * contact.
 *
 * After Zhong, Shirinzadeh, Alici, Smith: "Haptic deformation modelling through cellular neural
 * network", I. J. of Simulation 7 (8), 2006. A contact is a current source on the cells of the
 * touched nodes; the network's equilibrium is the discrete Poisson equation; the flux between two
 * cells becomes a force along the edge between two nodes. The paper leaves open which source acts
 * after unloading, whether there is a memory of rest, and whose lengths count. Taken literally
 * the body collapses or stays dented. The closure used here, with rest-geometry templates:
 *
 *   kap_i   normalised flux densities of a source on cell i alone (network.c, influence.c),
 *           at equilibrium or as far as the network has come in its own time (relax.c)
 *   kap     = sum_i w^_i kap_i over the cells that are touched
 *   eps     = 1/2 sum_e kap_e (|P_e|^2 - L0_e^2)        the flux-weighted mean Green strain, so
 *   psi     = E^ eps+^2 / 2 + T0 eta                    the source is modulus x strain (equation 5)
 *   eta     = 1/2 sum_e kap_e |u_e|^2                   pretension in balance at rest
 *   Pi      = sum_sources a psi + contact + 1/2 sum ks |P - P*|^2
 *             + sum_bodies 1/2 (B/V0) (sum N.u)^2
 *   m P'' + gamma P' = F - dPi/dP
 *
 * Pi is one potential of positions and tool poses, without memory: for fixed weights it is convex
 * (one equilibrium for each load, full return after it), all work is the tools' and the loads',
 * and touching, sliding, letting go and second tools need no case of their own. A cell saturates
 * at the output K: psi then grows linearly beyond eps_s (source.c); the cells of several
 * loads share what K leaves them (saturate.c).
 *
 * Where the nonlinearity comes from: eps is a Green strain, quadratic in the displacements, so
 * that bodies harden as they stretch; that is geometric. The network itself is linear until a cell
 * reaches K, which softens. The paper calls the nonlinearity the network's and not geometric; of
 * this closure that is true of saturation alone. Left out, as future work in the paper: cutting and
 * tearing. Links are the mesh's edges and stay.
 *
 * Nodes fixed on all axes are the cells at v = 0. A node fixed along some axes only is held along
 * these, and its cell conducts as any other. P* is P0 when fixed and prescribed axes stop every
 * rigid motion, else the best rigid fit of P0 (ks weights) at every stage; pretension and enclosed
 * volume are then refused, since their derivative through the fit is missing.
 *
 * The cells are the nodes of triangles, of a rectangular grid, or (domain: volume) of tetrahedra,
 * inner nodes included; templates.c has what differs, and everything here is the same for all.
 * In a volume tools and loads act on the surface, whose nodes alone are sources, E is a modulus in
 * Pa, and densities are per volume.
 *
 * State: u, v and the rounding error of u, four scalars a node, in the mesh's node order (the inner
 * nodes of a volume mesh whose surface alone is simulated stay at rest). Everything else is
 * derived. Displacements, never positions, so that single precision loses nothing far from the
 * origin.
 */
#include <math.h>
#include <string.h>

#include "models/common/dispatch.h"
#include "models/common/plan.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/vec.h"

SS_KERNEL_PATHS(ss_cnn_kernels)

/* ---- set-up ---- */

static ss_real *get_quads(ss_model *model)
{
    return ss_arena_get(&model->arena, ss_cnn_padded(model->node_count) * 4, sizeof(ss_real));
}

static ss_real *get_node_reals(ss_model *model, const double *from)
{
    ss_real *out = ss_arena_get(&model->arena, ss_cnn_padded(model->node_count), sizeof(ss_real));
    for (int32_t i = 0; out != NULL && i < model->node_count; ++i) {
        out[i] = (ss_real)from[i];
    }
    return out;
}

static softsim_status allocate_state(ss_model *model)
{
    ss_real **const quads[] = {
        &model->u,          &model->v,        &model->u_low,  &model->old_u,    &model->old_v,
        &model->old_low,    &model->us,       &model->vs[0],  &model->vs[1],    &model->vs[2],
        &model->load_force, &model->base,     &model->force,  &model->mobility, &model->inverse,
        &model->push,       &model->residual, &model->search, &model->scaled,   &model->product,
        &model->held_b};
    for (size_t k = 0; k < sizeof quads / sizeof *quads; ++k) {
        *quads[k] = get_quads(model);
    }
    model->fitted = model->is_held ? NULL : get_quads(model);
    model->normal = model->material.bulk == 0.0 ? NULL : get_quads(model);
    model->mass = get_node_reals(model, model->material.mass);
    model->damping = get_node_reals(model, model->material.damping);
    model->rest_stiffness = get_node_reals(model, model->material.rest_stiffness);
    ss_arena *arena = &model->arena;
    const size_t n = ss_cnn_padded(model->node_count);
    const size_t edges = (size_t)model->network->edges.padded_count;
    const size_t held = (size_t)model->network->held.entry_count;
    SS_ARENA_TAKE(arena, SS_ROOM(n, model->stiff), SS_ROOM(n, model->mobility_max),
                  SS_ROOM(edges, model->strain), SS_ROOM(edges, model->stretch),
                  SS_ROOM(held, model->held_kap), SS_ROOM(SS_CNN_WHOLE_INFLUENCE, model->column));
    return ss_arena_status(arena);
}

/* 1/m on every axis that may move; prescribed axes are taken out when their sets are read. */
static void set_mobility(ss_model *model)
{
    for (int32_t i = 0; i < model->node_count; ++i) {
        const double mass = model->material.mass[i];
        for (int k = 0; k < 3; ++k) {
            const bool is_free = mass > 0.0 && (model->plan.fixed[i] & (1 << k)) == 0;
            model->mobility[4 * (ptrdiff_t)i + k] = is_free ? (ss_real)(1.0 / mass) : 0;
        }
    }
}

/* What the step bound and the contact stiffness need of the free nodes. */
static void set_extremes(ss_model *model)
{
    model->damping_rate_min = model->smallest_sigma = (double)INFINITY;
    for (int32_t i = 0; i < model->node_count; ++i) {
        const ss_real *mobility = model->mobility + 4 * (ptrdiff_t)i;
        model->mobility_max[i] =
            fmax(fmax((double)mobility[0], (double)mobility[1]), (double)mobility[2]);
        if (model->mobility_max[i] > 0.0) {
            const double mass = model->material.mass[i];
            const double rate = model->material.damping[i] / mass;
            model->damping_rate_min = fmin(model->damping_rate_min, rate);
            model->damping_rate_max = fmax(model->damping_rate_max, rate);
            const double area = model->network->surface_area[i];
            if (area > 0.0) {
                model->smallest_sigma = fmin(model->smallest_sigma, mass / area);
            }
        }
    }
}

/* Centroid and size; of free bodies the weights of the fit. */
static void set_geometry(ss_model *model)
{
    const ss_mesh *mesh = model->plan.mesh;
    double size = 0.0;
    for (int32_t i = 0; i < model->node_count; ++i) {
        model->fit_weight += model->material.rest_stiffness[i];
        size += model->network->size[i];
    }
    model->diagonal = ss_mesh_diagonal(mesh);
    model->small_energy = 1e-3 * model->network->mean_edge *
                          (model->plan.working_force > 0.0 ? model->plan.working_force : 1.0);
    for (int32_t i = 0; i < model->node_count; ++i) {
        const double w = model->fit_weight > 0.0
                             ? model->material.rest_stiffness[i] / model->fit_weight
                             : model->network->size[i] / size;
        ss_madd3(model->centroid_rest, model->centroid_rest, w, mesh->position[i]);
    }
}

static softsim_status create_tool(ss_model *model, int index)
{
    const ss_model_plan *plan = &model->plan;
    const size_t n = (size_t)model->node_count;
    const double radius = ss_shape_curvature_radius(&plan->tool[index].shape);
    const double h = model->network->mean_edge;
    ss_tool *base = &model->tools.tool[index];
    ss_cnn_tool *tool = &model->tool[index];
    base->delta = plan->contact_reach > 0.0 ? plan->contact_reach : fmax(h, 0.5 * radius);
    base->radius = radius > 0.0 ? radius : base->delta;
    base->stiffness = ss_cnn_contact_stiffness(plan, model->smallest_sigma, base->radius);
    tool->full_weight = SS_PI * base->radius * base->delta / 3.0;
    tool->source.is_tool = true;
    ss_arena *arena = &model->arena;
    SS_ARENA_TAKE(arena, SS_ROOM(n, tool->mu), SS_ROOM(n, tool->fading_mu), SS_ROOM(n, tool->eps),
                  SS_ROOM(n, tool->eta), SS_ROOM(n, tool->share), SS_ROOM(n, tool->own_node),
                  SS_ROOM(n, tool->own_weight));
    tool->shape_y = get_quads(model);
    tool->weight_slope = get_quads(model);
    const softsim_status status = ss_cnn_source_init(model, &tool->source);
    return status == SOFTSIM_OK ? ss_tools_open(&model->tools, plan, index, arena) : status;
}

static softsim_status create_tools(ss_model *model, softsim_error *error)
{
    const ss_model_plan *plan = &model->plan;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        model->tool[k].base = &model->tools.tool[k];
    }
    if (ss_plan_tool_count(plan) == 0) {
        return SOFTSIM_OK;
    }
    softsim_status status = ss_tools_create(&model->tools, plan->mesh, plan, error);
    if (status == SOFTSIM_OK) {
        status = ss_cnn_network_solve_all(model->network, !model->is_relaxed, plan->threads, error);
    }
    for (int k = 0; status == SOFTSIM_OK && k < SOFTSIM_MAX_PROBES; ++k) {
        if (plan->tool[k].is_used) {
            status = create_tool(model, k);
        }
    }
    return status;
}

/* The network in its own time, for the cells that tools and loads may use. */
static softsim_status create_relaxation(ss_model *model, softsim_error *error)
{
    if (!model->is_relaxed) {
        return SOFTSIM_OK;
    }
    uint8_t *is_cell = ss_memory_get((size_t)model->node_count, sizeof *is_cell);
    if (!is_cell) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (model->plan.tool[k].is_used) {
            memcpy(is_cell, model->network->is_source, (size_t)model->node_count);
        }
    }
    for (int32_t k = 0; k < model->source_count; ++k) {
        for (int32_t c = 0; c < model->source[k].cell_count; ++c) {
            is_cell[model->source[k].cell[c]] = 1;
        }
    }
    const int32_t steps = (int32_t)model->plan.param[SS_CNN_RELAXATION_STEPS].number;
    const softsim_status status = ss_cnn_relax_create(model->network, model->plan.mesh, model->held,
                                                      is_cell, steps, &model->relax, error);
    ss_memory_free(is_cell);
    return status;
}

/* ---- the class ---- */

static void reset(ss_model *model)
{
    const size_t bytes = (size_t)model->node_count * 4 * sizeof(ss_real);
    ss_real *const cleared[] = {model->u,          model->v,     model->u_low,
                                model->old_u,      model->old_v, model->old_low,
                                model->load_force, model->base,  model->force};
    for (size_t k = 0; k < sizeof cleared / sizeof *cleared; ++k) {
        memset(cleared[k], 0, bytes);
    }
    for (int32_t k = 0; k < model->source_count; ++k) {
        model->source[k].is_on = false;
    }
    ss_loads_reset(&model->loads);
    ss_tools_reset(&model->tools);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_cnn_tool *tool = &model->tool[k];
        tool->count = 0;
        ss_cnn_source_end_contact(tool);
        tool->source.is_on = false;
        tool->source.given = 0.0;
        if (tool->base->is_used) {
            memset(tool->shape_y, 0, bytes);
        }
    }
    if (model->relax) {
        ss_cnn_relax_reset(model->relax);
    }
    ss_cnn_loads_build(model);
    model->step = 0;
    model->substeps = 0;
    model->work = model->load_work = model->dissipated = model->kinetic = model->elastic = 0.0;
    model->pool = model->owed = model->damped = 0.0;
    for (int32_t k = 0; k < model->enclosed_count; ++k) {
        model->enclosed[k].pressure = 0.0;
    }
    model->is_ready = false;
    model->has_loads_only = false;
    model->first = NULL;
    model->d = model->u;
    ss_cnn_active_set_reset(model);
    ss_inverted_reset(&model->inverted);
    model->worst = -1;
    model->fault_bits = 0;
    model->verdict = SOFTSIM_VERDICT_GOOD;
    model->reason = "";
    ss_cnn_set_bound(model);
}

static void destroy(ss_model *model)
{
    ss_tools_fini(&model->tools);
    ss_cnn_relax_destroy(&model->relax);
    ss_cnn_network_destroy(&model->network);
    ss_arena_free(&model->arena);
    ss_memory_free(model);
}

/* The parts in the order in which they need one another. */
static softsim_status build_on(ss_model *model, softsim_error *error)
{
    const ss_model_plan *plan = &model->plan;
    softsim_status status = ss_cnn_material_create(plan, &model->arena, &model->material, error);
    const softsim_status checked =
        ss_cnn_plan_check(plan, &model->material, &model->is_held, error);
    if (status != SOFTSIM_OK || checked != SOFTSIM_OK) {
        return status != SOFTSIM_OK ? status : checked;
    }
    model->held = ss_arena_get(&model->arena, (size_t)model->node_count, 1);
    if (!model->held) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        model->held[i] = (plan->fixed[i] & 7) == 7;
    }
    const ss_cnn_fabric fabric = ss_cnn_material_fabric(plan, &model->material);
    status = ss_cnn_network_create(&fabric, model->held, &model->network, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    model->whole_span = (ss_cnn_span){.node_end = (int32_t)ss_cnn_padded(model->node_count),
                                      .group_end = model->network->rows.group_count};
    model->whole = (ss_cnn_part){.count = 1, .span = &model->whole_span};
    model->part = &model->whole;
    status = allocate_state(model);
    if (status != SOFTSIM_OK) {
        return status;
    }
    set_mobility(model);
    status = ss_cnn_loads_create(model, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    set_extremes(model);
    set_geometry(model);
    status = ss_cnn_enclosed_create(model, error);
    status = status == SOFTSIM_OK ? create_relaxation(model, error) : status;
    status = status == SOFTSIM_OK ? create_tools(model, error) : status;
    status = status == SOFTSIM_OK ? ss_cnn_active_set_create(model) : status;
    if (status == SOFTSIM_OK) {
        status = ss_cnn_saturation_create(model, error);
    }
    if (status == SOFTSIM_OK) {
        ss_cnn_source_moduli(model);
        status = ss_cnn_set_rest_felt(model);
        reset(model);
    }
    return status;
}

static softsim_status build(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    model->plan = *plan;
    model->node_count = plan->mesh->node_count;
    ss_inverted_init(&model->inverted, plan->mesh, plan->step);
    model->kernels = ss_cnn_kernels_get();
    model->has_gravity = ss_norm3(plan->gravity) > 0.0;
    model->is_one_cell = plan->param[SS_CNN_SOURCE].number != 0.0;
    model->is_relaxed = plan->param[SS_CNN_SOLVER].number != 0.0;
    const softsim_status status = build_on(model, error);
    model->plan.param = NULL;
    return status;
}

/* The node that limits the step, where the step is the trouble; else -1. */
static int32_t limiting_node(const ss_model *model)
{
    int32_t worst = -1;
    double largest = 0.0;
    for (int32_t s = 0; model->verdict >= SOFTSIM_VERDICT_DEGRADED && s < model->part->count; ++s) {
        const ss_cnn_span *span = &model->part->span[s];
        for (int32_t i = span->node; i < span->node_end; ++i) {
            const double rate = model->stiff[i] * model->mobility_max[i];
            worst = rate > largest ? i : worst;
            largest = fmax(largest, rate);
        }
    }
    return worst;
}

static void info(const ss_model *model, ss_model_info *out)
{
    *out = (ss_model_info){.step = model->step,
                           .substeps = model->substeps,
                           .active_nodes =
                               model->set ? model->set->active_nodes : model->network->cell_count,
                           .worst_element = model->worst >= 0 ? model->worst : limiting_node(model),
                           .fault_bits = model->fault_bits,
                           .verdict = model->verdict,
                           .reason = model->reason,
                           .stable_step = model->bound,
                           .travelled = model->travelled,
                           .kinetic = model->kinetic,
                           .elastic = model->elastic,
                           .dissipated = model->dissipated,
                           .work = model->work,
                           .load_work = model->load_work};
}

static const ss_real *displacement(const ss_model *model)
{
    ss_cnn_active_set_fill(model);
    return model->u;
}

static const ss_real *velocity(const ss_model *model)
{
    ss_cnn_active_set_fill(model);
    return model->v;
}

static uint64_t hash_state(const ss_model *model, uint64_t seed)
{
    const size_t quads = (size_t)model->node_count * 4 * sizeof(ss_real);
    uint64_t hash = ss_inverted_hash(&model->inverted, ss_hash_bytes(seed, model->u_low, quads));
    if (model->owed > 0.0) {
        hash = ss_hash_bytes(hash, &model->owed, sizeof model->owed);
    }
    if (model->set) {
        const ss_cnn_active_set *set = model->set;
        hash = ss_hash_bytes(hash, set->distance, (size_t)set->block_count);
        hash = ss_hash_bytes(hash, set->y, sizeof set->y);
        hash = ss_hash_bytes(hash, set->w, sizeof set->w);
        hash = ss_hash_bytes(hash, &set->age, sizeof set->age);
        hash = ss_hash_bytes(hash, &set->tension, sizeof set->tension);
    }
    for (int32_t k = 0; k < model->source_count; ++k) {
        hash = ss_hash_bytes(hash, &model->source[k].is_on, sizeof(bool));
    }
    for (int32_t i = 0; model->relax && i < model->node_count; ++i) {
        const int32_t slot = model->relax->slot_of[i];
        for (int32_t j = 0; slot >= 0 && j < model->node_count; ++j) {
            const double potential = ss_cnn_relax_potential(model->relax, slot, j);
            hash = ss_hash_bytes(hash, &potential, sizeof potential);
        }
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_cnn_tool *tool = &model->tool[k];
        const ss_tool *base = tool->base;
        if (!base->is_used) {
            continue;
        }
        hash = ss_hash_bytes(hash, &tool->cell.node, sizeof tool->cell.node);
        hash = ss_hash_bytes(hash, &tool->cell.has_pressed, sizeof(bool));
        hash = ss_hash_bytes(hash, tool->shape_y, quads);
        hash = ss_tool_hash_felt(base, hash);
        hash = ss_hash_bytes(hash, &tool->source.reference, sizeof tool->source.reference);
        hash = ss_grasp_hash(&base->grasp, hash);
        if (base->has_friction) {
            hash = ss_contact_query_hash_friction(base->query, hash);
        }
    }
    return hash;
}

/* The modulus that is set is the one that counts from then on. What the change adds to or takes
 * from the stored energy is booked as work at the next step. */
static void set(ss_model *model, int32_t index, double value)
{
    ss_cnn_material *material = &model->material;
    const bool is_volume = material->element == SS_CNN_TETRAHEDRON;
    const bool is_modulus = index == SS_CNN_MODULUS_J ||
                            index == (is_volume ? SS_CNN_MODULUS_PA : SS_CNN_MODULUS_N_PER_M);
    if (is_modulus && value > 0.0 && isfinite(value)) {
        material->is_modulus_energy = index == SS_CNN_MODULUS_J;
        material->modulus = value;
    } else if (index == SS_CNN_PRETENSION_J && model->is_held && value >= 0.0 && isfinite(value)) {
        material->pretension = value;
    } else {
        return;
    }
    ss_cnn_source_moduli(model);
    model->is_ready = false;
}

SS_MODEL_CLASS(
    ss_model_cnn_energy, "cnn-energy",
    "a surface or volume in which a cellular neural network spreads the energy of contact",
    SS_MODEL_PARTS(ss_model, &ss_cnn_hints, ss_cnn_rows_table, ss_cnn_step_cost_us, build, destroy,
                   ss_cnn_step, ss_cnn_explain),
    SS_MODEL_STATE(ss_cnn_contacts, reset, info, displacement, velocity, ss_cnn_reaction,
                   hash_state),
    .potential = &ss_cnn_potential, .set = set, .takes_friction = true);
