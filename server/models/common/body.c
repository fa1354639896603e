/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/body_state.h"
/*
 * A body of point masses: its making, its masses, and what it says of itself. body_step.c has the
 * motion and its energy balance, body_load.c loads and supports, body_contact.c tools, body_felt.c
 * the stiffness that a hand feels, body_class.c the class of a model that is made of one.
 *
 * State is displacement and velocity, never position: single precision then loses nothing far
 * from the origin. Mass is lumped on the nodes (row sums of the linear elements): explicit steps
 * need no solve, and the error in frequency has the sign opposite to that of the linear element's
 * stiffness. Rejected: consistent mass.
 */
#include <math.h>
#include <string.h>

#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/note.h"
#include "rt/vec.h"

/* ---- masses and lengths ---- */

static double tet_volume(const ss_mesh *mesh, const int32_t c[4])
{
    double a[3], b[3], d[3], n[3];
    ss_sub3(a, mesh->position[c[1]], mesh->position[c[0]]);
    ss_sub3(b, mesh->position[c[2]], mesh->position[c[0]]);
    ss_sub3(d, mesh->position[c[3]], mesh->position[c[0]]);
    ss_cross3(n, a, b);
    return ss_dot3(n, d) / 6.0;
}

void ss_body_volume_masses(const ss_mesh *mesh, const double *density, bool per_element,
                           double *out_mass)
{
    memset(out_mass, 0, (size_t)mesh->node_count * sizeof *out_mass);
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        const int32_t *c = mesh->tetrahedron[t];
        const double rho =
            per_element ? density[t]
                        : 0.25 * (density[c[0]] + density[c[1]] + density[c[2]] + density[c[3]]);
        const double share = 0.25 * rho * fabs(tet_volume(mesh, c));
        for (int a = 0; a < 4; ++a) {
            out_mass[c[a]] += share;
        }
    }
}

void ss_body_area_masses(const ss_mesh *mesh, const double *density, double *out_mass)
{
    ss_mesh_node_areas(mesh, out_mass);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        out_mass[i] *= density[i];
    }
}

static double distance(const ss_mesh *mesh, int32_t a, int32_t b)
{
    double d[3];
    ss_sub3(d, mesh->position[a], mesh->position[b]);
    return ss_norm3(d);
}

double ss_body_mean_side(const ss_mesh *mesh)
{
    double sum = 0.0;
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        for (int a = 0; a < 3; ++a) {
            sum += distance(mesh, mesh->triangle[t][a], mesh->triangle[t][(a + 1) % 3]);
        }
    }
    return sum / (3.0 * mesh->triangle_count);
}

double ss_body_mean_edge(const ss_mesh *mesh)
{
    if (mesh->tetrahedron_count == 0) {
        return mesh->triangle_count > 0 ? ss_body_mean_side(mesh) : 0.0;
    }
    double sum = 0.0;
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        for (int a = 0; a < 4; ++a) {
            for (int b = a + 1; b < 4; ++b) {
                sum += distance(mesh, mesh->tetrahedron[t][a], mesh->tetrahedron[t][b]);
            }
        }
    }
    return sum / (6.0 * mesh->tetrahedron_count);
}

/* Runge-Kutta: |z| on the imaginary axis, the least anywhere else on the boundary of its region of
 * stability, and on the real axis. */
#define RK4_UNDAMPED 2.8284271247461903
#define RK4_LEAST    2.6155
#define RK4_REAL     2.7852

double ss_body_step_limit(ss_body_integrator integrator, double rate2, double viscous_time,
                          double mass_damping)
{
    const double omega = sqrt(rate2);
    if (integrator == SS_BODY_SYMPLECTIC_EULER) { /* any mass damping is stable */
        const double whole = sqrt(viscous_time * viscous_time + 4.0 / rate2) + viscous_time;
        return rate2 > 0.0 ? 4.0 / (rate2 * whole) : (double)INFINITY; /* nothing cancels */
    }
    const double damping = mass_damping + viscous_time * rate2;
    return fmin((damping > 0.0 ? RK4_LEAST : RK4_UNDAMPED) / omega, RK4_REAL / damping);
}

/* ---- set-up ---- */

static ss_real *get_quads(ss_body *body)
{
    return ss_arena_get(&body->arena, (size_t)body->nodes.padded_count * 4, sizeof(ss_real));
}

static softsim_status allocate(ss_body *body)
{
    ss_body_nodes *nodes = &body->nodes;
    ss_arena *arena = &body->arena;
    const size_t n = (size_t)nodes->padded_count;
    nodes->u = get_quads(body);
    nodes->v = get_quads(body);
    nodes->force = get_quads(body);
    nodes->mobility = get_quads(body);
    body->old_u = get_quads(body);
    body->load_force = get_quads(body);
    body->old_load = get_quads(body);
    for (int k = 0; k < 5 && body->own.integrator == SS_BODY_RK4; ++k) {
        body->stage[k] = get_quads(body);
    }
    SS_ARENA_TAKE(arena, SS_ROOM((size_t)nodes->count, nodes->rest), SS_ROOM(n, nodes->mass),
                  SS_ROOM(n, body->mass), SS_ROOM(n, body->axes), SS_ROOM(n, body->is_source),
                  SS_ROOM(n / SS_BODY_BLOCK + 1, body->is_idle));
    return ss_arena_status(arena);
}

/* Masses that are no numbers, or too small to divide by. */
static softsim_status check_masses(const ss_body_plan *plan, double *size, softsim_error *error)
{
    ss_number_list bad = {0};
    double sum = 0.0;
    for (int32_t i = 0; i < plan->node_count; ++i) {
        const double mass = plan->mass[i];
        const bool is_good =
            mass >= 0.0 && isfinite(mass) && (mass == 0.0 || isfinite((ss_real)(1.0 / mass)));
        if (!is_good) {
            ss_number_list_add(&bad, i < plan->plan->mesh->node_count
                                         ? ss_mesh_file_node(plan->plan->mesh, i)
                                         : i);
        }
        sum += is_good ? mass : 0.0;
        if (i < plan->plan->mesh->node_count) {
            size[i] = mass > 0.0 ? mass : -1.0;
        }
    }
    if (bad.count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "%s: %d nodes (first %s) have a mass that is not a number or too small "
                          "to divide by: give a density that fits the mesh's units",
                          plan->name, bad.count, bad.text);
    } else if (!(sum > 0.0)) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "%s: no element gives any node a mass: is the mesh of the right kind?",
                          plan->name);
    }
    return bad.count > 0 || !(sum > 0.0) ? SOFTSIM_ERROR_SCENE : SOFTSIM_OK;
}

static void set_nodes(ss_body *body)
{
    const ss_mesh *mesh = body->plan.mesh;
    ss_body_nodes *nodes = &body->nodes;
    double low[3], high[3];
    ss_bounds3(mesh->node_count, (const double(*)[3])mesh->position, low, high);
    body->diagonal = ss_mesh_diagonal(mesh);
    ss_add3(nodes->origin, low, high);
    ss_scale3(nodes->origin, nodes->origin, 0.5);
    for (int32_t i = 0; i < nodes->count; ++i) {
        const uint8_t fixed = i < mesh->node_count ? body->plan.fixed[i] & 7 : 0;
        const double mass = body->own.mass[i];
        if (i < mesh->node_count) {
            ss_sub3(nodes->rest[i], mesh->position[i], nodes->origin);
        }
        nodes->mass[i] = mass;
        body->mass[i] = (ss_real)mass;
        body->axes[i] = fixed;
        body->total_mass += mass;
        for (int k = 0; k < 3; ++k) {
            const bool is_free = mass > 0.0 && (fixed & (1 << k)) == 0;
            nodes->mobility[4 * (ptrdiff_t)i + k] = is_free ? (ss_real)(1.0 / mass) : 0;
        }
    }
    for (int32_t first = 0; first < nodes->count; first += SS_BODY_BLOCK) {
        ss_body_set_idle(body, first);
    }
    body->small_energy =
        1e-3 * body->own.edge * (body->plan.working_force > 0.0 ? body->plan.working_force : 1.0);
}

static softsim_status build(ss_body *body, softsim_error *error)
{
    double *size = ss_memory_get((size_t)body->mesh_count, sizeof *size);
    softsim_status status = allocate(body);
    if (!size || status != SOFTSIM_OK) {
        ss_memory_free(size);
        return SOFTSIM_ERROR_MEMORY;
    }
    const softsim_status weighed = check_masses(&body->own, size, error);
    status = ss_plan_check(&body->plan, body->own.name, size,
                           body->has_skin ? "that ride on others: take them out"
                                          : "that belong to no element: take them out",
                           &body->is_held, error);
    body->is_held = body->is_held || body->own.is_grounded;
    ss_memory_free(size);
    if (status != SOFTSIM_OK || weighed != SOFTSIM_OK) {
        return status != SOFTSIM_OK ? status : weighed;
    }
    set_nodes(body);
    status = ss_body_loads_create(body, error);
    for (int32_t i = 0; i < body->nodes.count; ++i) {
        const ss_real *mobility = body->nodes.mobility + 4 * (ptrdiff_t)i;
        body->is_source[i] = mobility[0] > 0 || mobility[1] > 0 || mobility[2] > 0;
    }
    if (status == SOFTSIM_OK && ss_plan_tool_count(&body->plan) > 0) {
        status = ss_body_tools_create(body, error);
    }
    return status;
}

softsim_status ss_body_create(const ss_body_plan *plan, ss_body **out_body, softsim_error *error)
{
    *out_body = NULL;
    ss_body *body = ss_memory_get(1, sizeof *body);
    softsim_error *own = ss_memory_get(1, sizeof *own); /* faults are counted, wanted or not */
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (body && own) {
        body->own = *plan;
        body->plan = *plan->plan;
        body->nodes.count = plan->node_count;
        body->nodes.padded_count = (plan->node_count + 7) / 8 * 8;
        body->mesh_count = plan->plan->mesh->node_count;
        body->has_skin = plan->skin.mesh != NULL;
        body->skin = body->has_skin ? plan->skin.mesh : plan->plan->mesh;
        body->has_gravity = ss_norm3(plan->plan->gravity) > 0.0;
        body->is_explicit = plan->elastic.advance == NULL;
        body->worst_element = -1;
        body->active_nodes = plan->plan->mesh->node_count;
        ss_inverted_init(&body->inverted, plan->plan->mesh, plan->plan->step);
        status = build(body, error ? error : own);
        body->own.plan = &body->plan;
        body->own.mass = NULL;
        body->plan.param = NULL;
    }
    ss_memory_free(own);
    if (status != SOFTSIM_OK) {
        ss_body_destroy(&body);
    }
    *out_body = body;
    return status;
}

softsim_status ss_body_start(ss_body *body)
{
    ss_body_reset(body);
    if (body->own.planned_step == 0.0) {
        const double share = body->own.step_share * body->law_step;
        const double parts = fmax(1.0, ceil(body->plan.step / share - 1e-9));
        body->own.planned_step = body->plan.step / parts;
    }
    ss_body_set_contact_stiffness(body);
    const softsim_status status = ss_body_set_rest_felt(body);
    ss_body_reset(body);
    return status;
}

void ss_body_destroy(ss_body **body)
{
    ss_body *gone = *body;
    *body = NULL;
    if (!gone) {
        return;
    }
    ss_tools_fini(&gone->tools);
    ss_arena_free(&gone->arena);
    ss_memory_free(gone);
}

ss_body_nodes *ss_body_get_nodes(ss_body *body)
{
    return &body->nodes;
}

const ss_body_nodes *ss_body_read_nodes(const ss_body *body)
{
    return &body->nodes;
}

/* ---- report ---- */

void ss_body_judge(ss_body *body, softsim_verdict verdict, uint32_t fault_bits, const char *reason)
{
    body->fault_bits |= fault_bits;
    if (verdict > body->verdict) {
        body->verdict = verdict;
        body->reason = reason;
    }
}

void ss_body_judge_inverted(ss_body *body, bool names_node)
{
    const int32_t t = ss_inverted_look(&body->inverted, body->nodes.u);
    if (t >= 0) {
        ss_body_judge(body, SOFTSIM_VERDICT_DEGRADED, 0, SS_INVERTED_REASON);
        body->worst_element = names_node ? body->plan.mesh->tetrahedron[t][0] : t;
    }
}

void ss_body_set_worst_element(ss_body *body, int32_t element)
{
    body->worst_element = element;
}

void ss_body_set_active_nodes(ss_body *body, int32_t count)
{
    body->active_nodes = count;
}

void ss_body_renew(ss_body *body)
{
    body->is_ready = false;
}

double ss_body_mass_damping(const ss_body *body)
{
    return body->own.mass_damping;
}

void ss_body_info(const ss_body *body, ss_model_info *out)
{
    *out = (ss_model_info){.step = body->step,
                           .substeps = body->substeps,
                           .active_nodes = body->active_nodes,
                           .worst_element = body->worst_element,
                           .fault_bits = body->fault_bits,
                           .verdict = body->verdict,
                           .reason = body->reason,
                           .stable_step = body->bound,
                           .travelled = body->travelled,
                           .kinetic = body->kinetic,
                           .elastic = body->elastic,
                           .dissipated = body->dissipated,
                           .work = body->work,
                           .load_work = body->load_work};
}

uint64_t ss_body_hash(const ss_body *body, uint64_t seed)
{
    uint64_t hash = ss_hash_bytes(seed, &body->nodes.kick_lag, sizeof body->nodes.kick_lag);
    hash = ss_hash_bytes(hash, &body->pool, sizeof body->pool);
    hash = ss_hash_bytes(hash, &body->is_slowed, sizeof body->is_slowed);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &body->tools.tool[k];
        const ss_body_touch *felt = &body->felt[k];
        if (tool->is_used) {
            hash = ss_hash_bytes(hash, felt->shape_y, ss_body_bytes(body));
            hash = ss_tool_hash_felt(tool, hash);
            hash = ss_hash_bytes(hash, &felt->age, sizeof felt->age);
            if (felt->age > 0) { /* a touch begins without a step */
                hash = ss_hash_bytes(hash, felt->shape_step, ss_body_bytes(body));
            }
            hash = ss_grasp_hash(&tool->grasp, hash);
            if (tool->has_friction) {
                hash = ss_contact_query_hash_friction(tool->query, hash);
            }
        }
    }
    hash = ss_inverted_hash(&body->inverted, hash);
    return body->own.elastic.hash ? body->own.elastic.hash(body->own.elastic.owner, hash) : hash;
}

void ss_body_reset(ss_body *body)
{
    ss_real *const cleared[] = {body->nodes.u, body->nodes.v, body->nodes.force, body->old_u};
    for (size_t k = 0; k < sizeof cleared / sizeof *cleared; ++k) {
        memset(cleared[k], 0, ss_body_bytes(body));
    }
    ss_body_tools_reset(body);
    ss_inverted_reset(&body->inverted);
    if (body->own.elastic.reset) {
        body->own.elastic.reset(body->own.elastic.owner);
    }
    ss_body_loads_reset(body);
    body->step = 0;
    body->substeps = 0;
    body->work = body->load_work = body->dissipated = 0.0;
    body->pool = body->removed = 0.0;
    body->kinetic = body->elastic = body->shadow = body->power = 0.0;
    body->nodes.kick_lag = body->booked_lag = 0.0;
    body->is_ready = body->has_elastic = false;
    body->is_slowed = body->was_slowed = false;
    body->fault_bits = 0;
    body->verdict = SOFTSIM_VERDICT_GOOD;
    body->reason = "";
    body->worst_element = -1;
    body->law_step = body->own.elastic.stable_step(body->own.elastic.owner, body);
    body->bound = body->law_step;
    body->contact_rate2 = 0.0;
}

/* ---- explanation ---- */

static void explain_tool(const ss_body *body, int index, const ss_notes *out)
{
    const ss_tool *tool = &body->tools.tool[index];
    ss_note_used(out, "contact.tools",
                 "tool %d: contact %.4g N/m^3, penetration %.3g m at %.3g N, %.4g N/m at rest",
                 index, tool->stiffness, ss_tool_largest_depth(tool, &body->plan),
                 body->plan.max_force, tool->rest_felt);
    ss_tool_say_limits(tool, index, &body->plan, ss_surface_mean_edge(body->tools.surface), out);
}

void ss_body_explain(const ss_body *body, const ss_notes *out)
{
    const double share = body->own.step_share * body->bound;
    ss_note_used(out, "body", "%d nodes, %.6g kg, %s, %s precision", body->nodes.count,
                 body->total_mass, body->is_held ? "held" : "free to move as a whole",
                 sizeof(ss_real) == sizeof(float) ? "single" : "double");
    if (body->is_explicit) {
        ss_note_used(out, "integrator", "%s",
                     body->own.integrator == SS_BODY_RK4 ? "classical Runge-Kutta"
                                                         : "symplectic Euler");
    }
    if (body->is_explicit && isfinite(share)) {
        ss_note_used(out, "stable step", "%.4g s at rest, sub-steps of at most %.2g of it",
                     body->bound, body->own.step_share);
    }
    if (body->is_explicit) {
        ss_plan_say_substeps(&body->plan, share, out);
    }
    if (!body->is_held && body->has_gravity) {
        ss_note_warning(
            out, "object.fixed",
            "gravity acts and supports do not hold the body, or not every part of it: what "
            "is not held falls");
    } else {
        ss_tools_warn_unheld(&body->tools, body->is_held, out);
    }
    ss_tools_warn_rounded(&body->tools, &body->plan, out);
    if (!(body->own.mass_damping > 0.0)) {
        ss_note_left_out(out, "mass damping", "model.mass_damping_per_s=1e-30",
                         "mass_damping_per_s is 0");
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (body->tools.tool[k].is_used) {
            explain_tool(body, k, out);
        }
    }
    if (body->tools.surface) {
        ss_note_used(out, "contact", "%lld samples",
                     (long long)ss_surface_sample_count(body->tools.surface));
        ss_tools_say_friction(&body->plan, out);
        ss_tools_say_grasp(&body->plan, out);
    }
}
