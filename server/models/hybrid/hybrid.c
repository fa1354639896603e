/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hybrid/hybrid.h"
/*
 * hybrid: a core of tetrahedra under a layer of particles that wake where a tool is.
 *
 * After "a new hybrid deformable model for haptic interactions": a coarse mesh moves the bulk
 * cheaply and a mesh-free layer gives the touched place detail. What the paper leaves open is
 * closed in layer.c (rows that are exact for affine maps), layer_kernels.c (forces), volume.c (one
 * volume shared by both: collar and sleeping skin), skin.c (the surface that is touched), wake.c
 * (activation), bound.c (the stable step); near.c gathers what the kernels walk through. Law,
 * viscosity and materials are those of `fem`; time, loads, tools and the energy balance the body's.
 *
 * Where the nonlinearity comes from: Green strain, as in `fem`, of both tetrahedra and particles,
 * and the pair forces of the share that is cohesion. Left out: cutting and tearing. Neighbours are
 * those at rest and stay.
 */
#include <math.h>
#include <string.h>

#include "mesh/tetrahedron.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* Fraction of the contact's stable step, as SS_HYBRID_STEP_SHARE (hybrid.h) is of the law's. The
 * law's reserve is for what stretches between two looks; the contact's is a bound, computed again
 * every sub-step, and 1.3 to 1.8 times its omega^2 (HM1). */
#define CONTACT_STEP_SHARE 0.9
/* Defaults of the reaches, in spacings. */
#define ACTIVATE_SPACINGS 4.0
#define DEACTIVATE_RATIO  1.3
/* Of a cell of the search grid: the reach within which max_active wake is a few. */
#define GRID_SPACINGS 2.0
/* Points for each particle that may be awake: its neighbours tied to the core around it. */
enum { POINTS_PER_AWAKE = 4, SPARE_POINTS = 400 };

static const ss_param_row rows[SS_HYBRID_ROW_COUNT] = {
    SS_FEM_ROWS,
    [SS_HYBRID_SPACING] =
        SS_PARAM(FIELD, "layer.spacing_m",
                 "of the particles; finer ones are halves, quarters or eighths of the coarsest",
                 SS_ABOVE(0, 1e3), .is_required = true, .fallback = SS_ABSENT),
    [SS_HYBRID_THICKNESS] =
        SS_PARAM(NUMBER, "layer.thickness_m",
                 "without object.outer: grows the layer outward from the mesh, or inward (below 0)",
                 SS_FROM(-1e3, 1e3), .fallback = SS_ABSENT),
    [SS_HYBRID_COHESION] = SS_PARAM(NUMBER, "layer.lennard_jones_share",
                                    "of the particles' shear stiffness that is their cohesion",
                                    SS_FROM(0, 1.0), .fallback = 0.05),
    [SS_HYBRID_STABILISATION] =
        SS_PARAM(NUMBER, "layer.stabilisation",
                 "stiffness against motions that the strain does not see, times the shear modulus",
                 SS_FROM(0, 100.0), .fallback = 0.3),
    [SS_HYBRID_ACTIVATE] = SS_PARAM(NUMBER, "layer.activate_m",
                                    "particles nearer than this to a tool wake; absent: 4 "
                                    "spacings; as far as the body is long: all, always",
                                    SS_ABOVE(0, 1e9), .fallback = SS_ABSENT),
    [SS_HYBRID_DEACTIVATE] = SS_PARAM(NUMBER, "layer.deactivate_m",
                                      "and further than this may sleep; absent: 1.3 times that",
                                      SS_ABOVE(0, 1e9), .fallback = SS_ABSENT),
    [SS_HYBRID_MAX_ACTIVE] =
        SS_PARAM(INTEGER, "layer.max_active", "the nearest ones wake where there are more",
                 SS_FROM(1, 1e6), .fallback = 600)};

/* ---- set-up ---- */

static softsim_status refuse(softsim_error *error, const char *text)
{
    softsim_error_add(error, SOFTSIM_ERROR_SCENE, "hybrid: %s", text);
    return SOFTSIM_ERROR_SCENE;
}

static softsim_status create_layer(ss_hybrid *hybrid, const ss_model_plan *plan,
                                   softsim_error *error)
{
    const ss_param_value *spacing = &plan->param[SS_HYBRID_SPACING];
    ss_layer_plan layer = {
        .mesh = plan->mesh, .spacing = spacing->number, .spacing_of = spacing->per_node};
    for (int32_t i = 0; spacing->per_node != NULL && i < plan->mesh->node_count; ++i) {
        layer.spacing = i == 0 ? spacing->per_node[0] : fmax(layer.spacing, spacing->per_node[i]);
    }
    const softsim_status status = ss_layer_create(&layer, &hybrid->layer, error);
    if (status == SOFTSIM_OK && hybrid->layer->skin_count == 0) {
        return refuse(error, "the mesh has no layer: give object.outer, or layer.thickness_m");
    }
    return status;
}

static softsim_status read_parameters(ss_hybrid *hybrid, const ss_model_plan *plan,
                                      softsim_error *error)
{
    const ss_param_value *param = plan->param;
    const ss_layer *layer = hybrid->layer;
    const double coarsest = layer->spacing[0];
    hybrid->cohesion = param[SS_HYBRID_COHESION].number;
    hybrid->stabilisation = param[SS_HYBRID_STABILISATION].number;
    hybrid->wake_reach = param[SS_HYBRID_ACTIVATE].is_given ? param[SS_HYBRID_ACTIVATE].number
                                                            : ACTIVATE_SPACINGS * coarsest;
    hybrid->sleep_reach = param[SS_HYBRID_DEACTIVATE].is_given
                              ? param[SS_HYBRID_DEACTIVATE].number
                              : DEACTIVATE_RATIO * hybrid->wake_reach;
    if (hybrid->sleep_reach < hybrid->wake_reach) {
        return refuse(error, "layer.deactivate_m is less than layer.activate_m; give more, or "
                             "particles would wake and sleep at once");
    }
    if (param[SS_FEM_LOCKING_CURE].number == 2.0) {
        return refuse(error, "locking_cure: nodal-pressure is for whole volumes, and the layer "
                             "takes part of the core's; use none, or the model fem");
    }
    hybrid->is_all_awake = hybrid->wake_reach >= ss_mesh_diagonal(plan->mesh);
    hybrid->max_awake = (int32_t)param[SS_HYBRID_MAX_ACTIVE].number;
    if (hybrid->is_all_awake && hybrid->max_awake < layer->own_count) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "hybrid: layer.activate_m wakes all %d particles, and layer.max_active "
                          "is %d; raise it, or wake fewer",
                          layer->own_count, hybrid->max_awake);
        return SOFTSIM_ERROR_SCENE;
    }
    hybrid->max_awake = hybrid->max_awake < layer->own_count ? hybrid->max_awake : layer->own_count;
    const int64_t points = (int64_t)POINTS_PER_AWAKE * hybrid->max_awake + SPARE_POINTS;
    hybrid->max_points =
        hybrid->is_all_awake || points > layer->count ? layer->count : (int32_t)points;
    memcpy(hybrid->material.lambda_own, hybrid->material.lambda,
           (size_t)plan->mesh->tetrahedron_count * sizeof(double));
    hybrid->is_locking = hybrid->material.is_averaged;
    hybrid->material.is_averaged = false;
    hybrid->skin_edge = ss_body_mean_side(plan->mesh);
    hybrid->least_spacing = coarsest;
    for (int32_t p = 0; p < layer->count; ++p) {
        hybrid->least_spacing = fmin(hybrid->least_spacing, layer->spacing[p]);
    }
    return SOFTSIM_OK;
}

/* Skin has no mass: pressure on it would push nothing, and nobody would be told. */
static softsim_status check_pressures(const ss_hybrid *hybrid, const ss_model_plan *plan,
                                      softsim_error *error)
{
    const ss_mesh *mesh = plan->mesh;
    uint8_t *mark = ss_memory_get((size_t)mesh->node_count, 1);
    softsim_status status = mark != NULL ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    for (int32_t l = 0; mark != NULL && l < plan->load_count; ++l) {
        const ss_load *load = &plan->load[l];
        int32_t lost = 0;
        memset(mark, 0, (size_t)mesh->node_count);
        for (int32_t k = 0; load->is_pressure && k < load->node_count; ++k) {
            if (load->node[k] >= 0 && load->node[k] < mesh->node_count) {
                mark[load->node[k]] = 1;
            }
        }
        for (int32_t t = 0; t < mesh->triangle_count; ++t) {
            const int32_t *c = mesh->triangle[t];
            const int32_t *of = hybrid->layer->skin_of;
            lost += mark[c[0]] && mark[c[1]] && mark[c[2]] &&
                    (of[c[0]] >= 0 || of[c[1]] >= 0 || of[c[2]] >= 0);
        }
        if (lost > 0) {
            status = SOFTSIM_ERROR_SCENE;
            softsim_error_add(error, status,
                              "hybrid: load %d is a pressure on %d triangles of the outer surface, "
                              "whose nodes ride on the layer; press on the core's own faces, or "
                              "with a tool",
                              l, lost);
        }
    }
    ss_memory_free(mark);
    return status;
}

static bool create_core(ss_hybrid *hybrid)
{
    const ss_mesh *mesh = hybrid->mesh;
    const size_t elements = (size_t)mesh->tetrahedron_count;
    const ss_fem_stuff stuff = {.node_count = mesh->node_count,
                                .mesh = mesh,
                                .moduli = ss_fem_moduli_of(&hybrid->material)};
    hybrid->volume = ss_arena_get(&hybrid->arena, elements, sizeof *hybrid->volume);
    hybrid->lane = ss_arena_get(&hybrid->arena, elements, sizeof *hybrid->lane);
    if (!ss_fem_blocks_create(&stuff, &hybrid->arena, &hybrid->core)) {
        return false;
    }
    for (int32_t k = 0; k < hybrid->core.count * SS_FEM_LANES; ++k) {
        const int32_t e = hybrid->core.element[k];
        if (e >= 0) {
            const int32_t *c = mesh->tetrahedron[e];
            double gradient[4][3];
            hybrid->lane[e] = k;
            hybrid->volume[e] =
                ss_tetrahedron_gradients(mesh->position[c[0]], mesh->position[c[1]],
                                         mesh->position[c[2]], mesh->position[c[3]], gradient);
        }
    }
    return true;
}

static bool create_points(ss_hybrid *hybrid)
{
    const size_t points = (size_t)hybrid->max_points;
    const size_t columns = 8 * (1 + 3 * (points + SS_FEM_LANES));
    SS_ARENA_TAKE(&hybrid->arena, SS_ROOM(points, hybrid->point),
                  SS_ROOM(2 * points, hybrid->coefficient), SS_ROOM(columns, hybrid->gradient),
                  SS_ROOM(columns, hybrid->stress), SS_ROOM(8 * points, hybrid->spread));
    return ss_hybrid_create_blocks(hybrid, hybrid->max_points, &hybrid->points);
}

static bool create_particles(ss_hybrid *hybrid)
{
    const size_t n = (size_t)hybrid->layer->count;
    const size_t awake = (size_t)hybrid->max_awake;
    SS_ARENA_TAKE(&hybrid->arena, SS_ROOM(n, hybrid->particle), SS_ROOM(n, hybrid->node_of),
                  SS_ROOM(n, hybrid->is_held), SS_ROOM(4 * n, hybrid->offset),
                  SS_ROOM(n, hybrid->near), SS_ROOM(awake, hybrid->wanted),
                  SS_ROOM(awake, hybrid->idle), SS_ROOM(n, hybrid->drifting),
                  SS_ROOM(n, hybrid->distance), SS_ROOM(n, hybrid->found));
    if (ss_arena_status(&hybrid->arena) != SOFTSIM_OK) {
        return false;
    }
    for (size_t p = 0; p < n; ++p) {
        hybrid->particle[p] = (ss_hybrid_particle){.point = -1, .near = -1, .wanted = -1};
        hybrid->node_of[p] = -1;
        hybrid->distance[p] = (double)INFINITY;
    }
    ss_hybrid_idle_all(hybrid);
    return ss_point_grid_init(&hybrid->grid, hybrid->layer->own_count,
                              (const double(*)[3])hybrid->layer->rest,
                              GRID_SPACINGS * hybrid->layer->spacing[0], &hybrid->arena);
}

/* The contact's samples weigh a triangle's corners and the ring around them: the longest edge of a
 * skin node and of its neighbours. False when out of memory. */
static bool fill_spans(ss_hybrid *hybrid)
{
    const ss_mesh *mesh = hybrid->mesh;
    double *longest = ss_memory_get((size_t)mesh->node_count, sizeof *longest);
    const bool is_good = longest != NULL;
    for (int32_t c = 0; is_good && c < 3 * mesh->triangle_count; ++c) {
        const int32_t i = mesh->triangle[c / 3][c % 3];
        const int32_t j = mesh->triangle[c / 3][(c + 1) % 3];
        double d[3];
        ss_sub3(d, mesh->position[i], mesh->position[j]);
        longest[i] = fmax(longest[i], ss_norm3(d));
        longest[j] = fmax(longest[j], ss_norm3(d));
    }
    for (int32_t t = 0; is_good && t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        const double most = fmax(longest[c[0]], fmax(longest[c[1]], longest[c[2]]));
        for (int k = 0; k < 3; ++k) {
            const int32_t s = hybrid->layer->skin_of[c[k]];
            if (s >= 0) {
                hybrid->span[s] = fmax(hybrid->span[s], most);
            }
        }
    }
    ss_memory_free(longest);
    return is_good;
}

/* Nodes that the particles of skin node s are tied to; `mark` (by node, -1) is left as it was. */
static int32_t count_ties(const ss_hybrid *hybrid, int32_t s)
{
    const ss_layer *layer = hybrid->layer;
    int32_t count = 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int32_t k = layer->skin_first[s]; k < layer->skin_first[s + 1]; ++k) {
            const int32_t p = layer->skin_particle[k];
            for (int32_t t = layer->tie_first[p]; t < layer->tie_first[p + 1]; ++t) {
                int32_t *mark = &hybrid->mark[layer->tie_node[t]];
                count += pass == 0 && *mark < 0;
                *mark = pass == 0 ? 0 : -1;
            }
        }
    }
    return count;
}

/* Room for the row of every skin node, whichever of its particles are awake. */
static bool create_rides(ss_hybrid *hybrid)
{
    const ss_layer *layer = hybrid->layer;
    size_t entries = 0;
    for (int pass = 0; pass < 2; ++pass) {
        entries = 0;
        for (int32_t s = 0; s < layer->skin_count; ++s) {
            if (pass == 1) {
                hybrid->ride[s].node = hybrid->ride_node + entries;
                hybrid->ride[s].weight = hybrid->ride_weight + entries;
            }
            const int32_t particles = layer->skin_first[s + 1] - layer->skin_first[s];
            entries += (size_t)(particles + count_ties(hybrid, s));
        }
        if (pass == 0) {
            hybrid->ride_node = ss_arena_get(&hybrid->arena, entries, sizeof *hybrid->ride_node);
            hybrid->ride_weight =
                ss_arena_get(&hybrid->arena, entries, sizeof *hybrid->ride_weight);
            if (ss_arena_status(&hybrid->arena) != SOFTSIM_OK) {
                return false;
            }
        }
    }
    return true;
}

/* Which skin nodes ride on a particle; and the arrays of the skin. */
static bool create_skin(ss_hybrid *hybrid)
{
    const ss_layer *layer = hybrid->layer;
    const size_t skin = (size_t)layer->skin_count;
    const size_t all = (size_t)hybrid->mesh->node_count;
    const size_t nodes = (size_t)(hybrid->mesh->node_count + hybrid->max_awake);
    const int32_t entries = layer->skin_first[layer->skin_count];
    SS_ARENA_TAKE(&hybrid->arena, SS_ROOM((size_t)layer->count + 2, hybrid->rider_first),
                  SS_ROOM((size_t)entries, hybrid->rider), SS_ROOM(skin, hybrid->ride),
                  SS_ROOM(skin, hybrid->riding), SS_ROOM(skin, hybrid->riding_at),
                  SS_ROOM(nodes, hybrid->mark), SS_ROOM(4 * all, hybrid->shown),
                  SS_ROOM(4 * all, hybrid->shown_v), SS_ROOM(4 * all, hybrid->laid),
                  SS_ROOM(skin, hybrid->span), SS_ROOM(skin, hybrid->close),
                  SS_ROOM(skin, hybrid->around), SS_ROOM(all, hybrid->core_node),
                  SS_ROOM(nodes, hybrid->load), SS_ROOM(all, hybrid->swing),
                  SS_ROOM(4 * nodes, hybrid->mode), SS_ROOM(4 * nodes, hybrid->product));
    if (ss_arena_status(&hybrid->arena) != SOFTSIM_OK) {
        return false;
    }
    for (int32_t i = 0; i < hybrid->mesh->node_count; ++i) {
        if (layer->skin_of[i] < 0) {
            hybrid->core_node[hybrid->core_count++] = i;
        }
    }
    memset(hybrid->riding_at, 0xff, skin * sizeof *hybrid->riding_at);
    memset(hybrid->mark, 0xff, nodes * sizeof *hybrid->mark);
    for (int32_t k = 0; k < entries; ++k) {
        ++hybrid->rider_first[layer->skin_particle[k] + 2];
    }
    for (int32_t p = 0; p < layer->count; ++p) {
        hybrid->rider_first[p + 2] += hybrid->rider_first[p + 1];
    }
    for (int32_t s = 0; s < layer->skin_count; ++s) {
        for (int32_t k = layer->skin_first[s]; k < layer->skin_first[s + 1]; ++k) {
            hybrid->rider[hybrid->rider_first[layer->skin_particle[k] + 1]++] = s;
        }
    }
    return create_rides(hybrid) && fill_spans(hybrid);
}

/* Masses while all sleeps: a quarter of its own and of its guests' to each corner of an element. */
static void fill_masses(const ss_hybrid *hybrid, double *mass)
{
    const ss_mesh *mesh = hybrid->mesh;
    const ss_layer *layer = hybrid->layer;
    ss_body_volume_masses(mesh, hybrid->material.density, true, mass);
    for (int32_t p = 0; p < layer->own_count; ++p) {
        const int32_t e = layer->host[p];
        for (int k = 0; k < 4; ++k) {
            mass[mesh->tetrahedron[e][k]] += 0.25 * layer->volume[p] * hybrid->material.density[e];
        }
    }
}

/* Skin nodes ride and cannot be held themselves: the particles under those that are stay tied. */
static void hold(ss_hybrid *hybrid, uint8_t *fixed)
{
    const ss_layer *layer = hybrid->layer;
    for (int32_t s = 0; s < layer->skin_count; ++s) {
        if (fixed[layer->skin_node[s]] != 0) {
            ++hybrid->held_skin;
            fixed[layer->skin_node[s]] = 0;
            for (int32_t k = layer->skin_first[s]; k < layer->skin_first[s + 1]; ++k) {
                hybrid->is_held[layer->skin_particle[k]] = 1;
            }
        }
    }
}

static bool is_any_held(const uint8_t *fixed, int32_t count)
{
    bool is_held = false;
    for (int32_t i = 0; i < count; ++i) {
        is_held = is_held || fixed[i] != 0;
    }
    return is_held;
}

static void slept_owner(void *owner, int64_t steps)
{
    ((ss_hybrid *)owner)->step_counter += (uint32_t)steps;
}

static void reset_owner(void *owner)
{
    ss_hybrid *hybrid = owner;
    ss_hybrid_reset_layer(hybrid);
    ss_hybrid_forget(hybrid);
}

static uint64_t hash_layer(const void *owner, uint64_t seed)
{
    const ss_hybrid *hybrid = owner;
    for (int32_t k = 0; k < hybrid->point_count; ++k) {
        const int32_t p = hybrid->point[k];
        const ss_hybrid_particle *particle = &hybrid->particle[p];
        const ss_real value[5] = {(ss_real)p, particle->blend, hybrid->offset[4 * (ptrdiff_t)p],
                                  hybrid->offset[4 * (ptrdiff_t)p + 1],
                                  hybrid->offset[4 * (ptrdiff_t)p + 2]};
        seed = ss_hash_bytes(seed, value, sizeof value);
        seed = ss_hash_bytes(seed, &hybrid->node_of[p], sizeof hybrid->node_of[p]);
    }
    return seed;
}

static softsim_status create_body(ss_hybrid *hybrid, const ss_model_plan *plan, const double *mass,
                                  double planned_step, softsim_error *error)
{
    double density = (double)INFINITY;
    for (int32_t e = 0; e < plan->mesh->tetrahedron_count; ++e) {
        density = fmin(density, hybrid->material.density[e]);
    }
    const ss_body_plan body = {
        .name = "hybrid",
        .plan = plan,
        .node_count = plan->mesh->node_count + hybrid->max_awake,
        .mass = mass,
        .mass_damping = hybrid->material.mass_damping,
        .edge = fmin(hybrid->least_spacing, ss_body_mean_edge(plan->mesh)),
        .planned_step = planned_step,
        .step_share = SS_HYBRID_STEP_SHARE,
        .contact_share = CONTACT_STEP_SHARE,
        .integrator = hybrid->material.integrator,
        .elastic = {SS_BODY_ELASTIC(hybrid, ss_hybrid_force, ss_hybrid_tangent, ss_hybrid_diagonal,
                                    ss_hybrid_stable_step),
                    .viscous_time = hybrid->material.viscous_time, .reset = reset_owner,
                    .slept = slept_owner, .hash = hash_layer},
        .skin = {.mesh = plan->mesh,
                 .sigma = density * hybrid->least_spacing,
                 .lay = ss_hybrid_lay,
                 .carry = ss_hybrid_carry,
                 .carry_diagonal = ss_hybrid_carry_diagonal,
                 .rate2 = ss_hybrid_carry_rate2}};
    return ss_body_create(&body, &hybrid->body, error);
}

/* The stable step is that of a body, and the body's contact needs the stable step: a bare body is
 * measured first. */
static softsim_status measure_and_create_body(ss_hybrid *hybrid, const ss_model_plan *plan,
                                              const double *mass, softsim_error *error)
{
    ss_model_plan bare = *plan;
    bare.load_count = 0;
    bare.prescribed_count = 0;
    memset(bare.tool, 0, sizeof bare.tool);
    softsim_status status = create_body(hybrid, &bare, mass, 1.0, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_hybrid_measure(hybrid);
    ss_hybrid_reset_layer(hybrid);
    const bool is_all_awake = hybrid->is_all_awake;
    hybrid->is_all_awake = false; /* the new body begins with its masses asleep */
    ss_hybrid_reset_layer(hybrid);
    hybrid->is_all_awake = is_all_awake;
    ss_body_destroy(&hybrid->body);
    const double limit =
        ss_body_step_limit(hybrid->material.integrator, hybrid->rest_rate2,
                           hybrid->material.viscous_time, hybrid->material.mass_damping);
    status = create_body(hybrid, plan, mass, SS_HYBRID_STEP_SHARE * limit, error);
    if (status == SOFTSIM_OK) {
        hybrid->u = ss_body_read_nodes(hybrid->body)->u;
        status = ss_body_start(hybrid->body);
    }
    return status;
}

static softsim_status build_on(ss_hybrid *hybrid, const ss_model_plan *plan, softsim_error *error)
{
    softsim_status status =
        ss_fem_material_create(plan, "hybrid", &hybrid->arena, &hybrid->material, error);
    if (status == SOFTSIM_OK) {
        status = create_layer(hybrid, plan, error);
    }
    if (status == SOFTSIM_OK) {
        status = read_parameters(hybrid, plan, error);
    }
    if (status == SOFTSIM_OK) {
        status = check_pressures(hybrid, plan, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    const size_t nodes = (size_t)plan->mesh->node_count;
    ss_model_plan own = *plan;
    double *mass = ss_arena_get(&hybrid->arena, nodes + (size_t)hybrid->max_awake, sizeof *mass);
    hybrid->mass_asleep = mass;
    hybrid->fixed = ss_arena_get(&hybrid->arena, nodes, 1);
    if (mass == NULL || hybrid->fixed == NULL || !create_core(hybrid) ||
        !ss_hybrid_create_cells(hybrid) || !create_points(hybrid) || !create_particles(hybrid) ||
        !ss_hybrid_create_near(hybrid) || !create_skin(hybrid)) {
        return SOFTSIM_ERROR_MEMORY;
    }
    memcpy(hybrid->fixed, plan->fixed, nodes);
    hold(hybrid, hybrid->fixed);
    if (hybrid->held_skin > 0 && !is_any_held(hybrid->fixed, plan->mesh->node_count)) {
        return refuse(error,
                      "object.fixed: all nodes that are held lie on the layer, which rides on "
                      "the core, and the core would fall; hold nodes of the core too, or let "
                      "the layer be thinner there");
    }
    own.fixed = hybrid->fixed;
    memcpy(hybrid->shape, plan->tool, sizeof hybrid->shape);
    fill_masses(hybrid, mass);
    return measure_and_create_body(hybrid, &own, mass, error);
}

static void destroy(ss_model *model)
{
    ss_hybrid *hybrid = (ss_hybrid *)model;
    ss_body_destroy(&hybrid->body);
    ss_layer_destroy(&hybrid->layer);
    ss_arena_free(&hybrid->arena);
    ss_memory_free(hybrid);
}

static softsim_status build(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    ss_hybrid *hybrid = (ss_hybrid *)model;
    hybrid->mesh = plan->mesh;
    hybrid->law = ss_fem_kernels_get();
    hybrid->kernels = ss_layer_kernels_get();
    const softsim_status status = build_on(hybrid, plan, error);
    for (int k = 0; status == SOFTSIM_OK && k < SOFTSIM_MAX_PROBES; ++k) {
        if (hybrid->shape[k].is_used) {
            const double radius = ss_shape_bounding_radius(&hybrid->shape[k].shape);
            hybrid->close_reach[k] = radius + 3.5 * hybrid->skin_edge;
            hybrid->around_reach[k] = radius + hybrid->sleep_reach + 1.5 * hybrid->skin_edge;
        }
    }
    return status;
}

/* ---- the class ---- */

static void step(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    ss_hybrid *hybrid = (ss_hybrid *)model;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        hybrid->tool[k] = tool != NULL ? tool[k] : (ss_model_tool){0};
        hybrid->tool[k].is_present = hybrid->tool[k].is_present && hybrid->shape[k].is_used;
    }
    ss_model_info now;
    ss_body_info(hybrid->body, &now);
    if ((now.fault_bits & SS_MODEL_FAULT_NOT_FINITE) == 0) { /* else all stays as it was */
        ss_hybrid_list_skin(hybrid);
        if (ss_hybrid_wake(hybrid)) {
            ss_body_renew(hybrid->body);
        }
    }
    ss_body_step(hybrid->body, time, dt, tool);
    ss_body_judge_inverted(hybrid->body, false);
}

static const ss_real *displacement(const ss_model *model)
{
    const ss_hybrid *hybrid = (const ss_hybrid *)model;
    ss_hybrid_show(hybrid, ss_body_read_nodes(hybrid->body)->u, hybrid->shown);
    return hybrid->shown;
}

static const ss_real *velocity(const ss_model *model)
{
    const ss_hybrid *hybrid = (const ss_hybrid *)model;
    ss_hybrid_show(hybrid, ss_body_read_nodes(hybrid->body)->v, hybrid->shown_v);
    return hybrid->shown_v;
}

/* A thin layer outside the body's surface, so that the core has the body's nodes, all of them; it
 * sleeps while there is no tool. */
static void write_case(FILE *file, const ss_model_class *model, const ss_hints_setting *setting)
{
    const double spacing = 0.012 * setting->body->size;
    ss_hints_write_solid(file, model, setting);
    fprintf(file, "  layer: {spacing_m: %.9g, thickness_m: %.9g}\n", spacing, 3.0 * spacing);
}

static const ss_hints_variant variant = {.name = "hybrid",
                                         .text =
                                             "  layer: {spacing_m: 0.0125, thickness_m: 0.0125}\n",
                                         .knob = SS_HINTS_SOLID};
static const ss_model_hints hints = {
    .colour = "#7f3f98",
    .about = "the finite elements of fem under a layer of particles, which sleep while no tool is "
             "near, as here; the layer lies outside the body and makes it a little thicker, which "
             "is in its error",
    .note = "the layer outside makes it a thicker body than the case's",
    .has_force = true,
    .material = SS_HINTS_ANY_LAW,
    .write = write_case,
    .fitted = {SS_HINTS_MODULI, SS_HINTS_VISCOSITIES},
    .variant = &variant,
    .variant_count = 1};

static const ss_layer *layer_at_rest(const ss_model *model)
{
    return ((const ss_hybrid *)model)->layer;
}

static bool is_awake(const ss_model *model, int32_t particle)
{
    return ((const ss_hybrid *)model)->node_of[particle] >= 0;
}

static double ride_share(const ss_model *model, int32_t skin)
{
    return (double)((const ss_hybrid *)model)->ride[skin].theta;
}

static const ss_model_layer layer_class = {
    .full = SS_HYBRID_FULL, .at_rest = layer_at_rest, .is_awake = is_awake, .share = ride_share};

SS_MODEL_CLASS(ss_model_hybrid, "hybrid",
               "a core of tetrahedra under a layer of particles that wake where a tool is",
               SS_MODEL_PARTS(ss_hybrid, &hints, rows, ss_hybrid_step_cost_us, build, destroy, step,
                              ss_hybrid_explain),
               SS_BODY_STATE(ss_body_model_info, displacement, velocity), .needs_volume = true,
               .layer = &layer_class);
