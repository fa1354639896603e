/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/body_state.h"
/*
 * Tools against a body: penalty on the samples of a smooth surface (contact.h), grasps, and how
 * stiff the contact may be.
 *
 * A sample that is d deep pushes with A kc c(d), kc in N/m^3: the same on every mesh; c(d) is d,
 * ten times as steep beyond 0.3 of the tool's inradius (contact/query.c). kc is as stiff as the
 * planned sub-step h allows, kc <= share sigma / h^2 with sigma the mean mass per area of the
 * surface's nodes, and no stiffer than a penetration of a tenth of the radius at the working force,
 * F_w / (0.03 R^3). With omega_c^2 = max_i k_i / m_i of the samples that touch now, k_i = kc sum_q
 * A_q c'(d_q) B_qi, and omega_e the law's, omega^2 <= omega_e^2 + omega_c^2 bounds every mode
 * (largest eigenvalues of sums), so that sub-steps shorten by what the contact takes and no more.
 * The planned step and the cost hold for c' = 1, a contact at its working depth. One that is deeper
 * takes up to sqrt 10 times the sub-steps, and takes them: none is longer than the bound with c'
 * at its beginning. What max_substeps leaves undone is told as slower than real time. A sample that
 * goes over to c' = 10 within a sub-step is met by the next; the energy balance judges both.
 * The contact's surface is the mesh's, or one of the model's own that rides on the nodes: x_s =
 * S x; forces return by S^T, omega_c^2 is what the model says of M^-1 S^T k S.
 * Rejected: contact as constraints (a force that ripples as samples come and go, and no energy to
 * balance the hand against).
 */
#include <math.h>
#include <string.h>

#include "models/common/plan.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* omega_c^2 h^2 of a node of mean mass per area, h the planned sub-step: times edge / radius, and
 * its bounds. A node by itself resists with about a quarter of 1/h^2 of its mass, tissue under a
 * tool with edge / radius of that: 3 makes the contact some ten times as stiff as the tissue. Where
 * the mesh is as coarse as the tool its sub-steps are cheap; where it is fine less will do. The
 * edges of a model's own skin say nothing of what carries it, which its least sigma does. */
#define CONTACT_SHARE     3.0
#define MIN_CONTACT_SHARE 0.5
#define MAX_CONTACT_SHARE 3.0

/* ---- set-up ---- */

/* Mass per area of the nodes that may move, over all of them. */
static double mean_sigma(const ss_body *body)
{
    const ss_mesh *mesh = body->plan.mesh;
    double *area = ss_memory_get((size_t)mesh->node_count, sizeof *area);
    if (!area) {
        return -1.0;
    }
    double mass = 0.0, sum = 0.0;
    ss_mesh_node_areas(mesh, area);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (body->is_source[i] && area[i] > 0.0) {
            mass += body->nodes.mass[i];
            sum += area[i];
        }
    }
    ss_memory_free(area);
    return sum > 0.0 ? mass / sum : (double)INFINITY;
}

static softsim_status create_tool(ss_body *body, int index)
{
    const ss_model_plan *plan = &body->plan;
    ss_tool *tool = &body->tools.tool[index];
    const double radius = ss_shape_curvature_radius(&plan->tool[index].shape);
    const size_t quads = (size_t)body->nodes.padded_count * 4;
    tool->delta = plan->contact_reach > 0.0
                      ? plan->contact_reach
                      : fmax(ss_surface_mean_edge(body->tools.surface), 0.5 * radius);
    tool->radius = radius > 0.0 ? radius : tool->delta;
    tool->stiffness = 1.0; /* until the planned step is known */
    body->felt[index].shape_y = ss_arena_get(&body->arena, quads, sizeof(ss_real));
    body->felt[index].shape_step = ss_arena_get(&body->arena, quads, sizeof(ss_real));
    return ss_tools_open(&body->tools, plan, index, &body->arena);
}

static softsim_status allocate(ss_body *body)
{
    const size_t n = (size_t)body->nodes.padded_count;
    const size_t skin = (size_t)(body->skin->node_count + 7) / 8 * 8;
    ss_arena *arena = &body->arena;
    ss_body_solver *solver = &body->solver;
    ss_real **const quads[] = {&solver->inverse, &solver->push,   &solver->residual,
                               &solver->search,  &solver->scaled, &solver->product,
                               &solver->swift};
    for (size_t k = 0; k < sizeof quads / sizeof *quads; ++k) {
        *quads[k] = ss_arena_get(arena, n * 4, sizeof **quads[k]);
    }
    SS_ARENA_TAKE(arena, SS_ROOM(n, solver->stiff), SS_ROOM(n, body->contact_stiff),
                  SS_ROOM(skin * 4, body->skin_force), SS_ROOM(skin, body->skin_stiff),
                  SS_ROOM(skin, body->is_stiff), SS_ROOM(skin, body->stiff_node));
    body->skin_u = body->has_skin ? ss_arena_get(arena, skin * 4, sizeof *body->skin_u) : NULL;
    return ss_arena_status(arena);
}

softsim_status ss_body_tools_create(ss_body *body, softsim_error *error)
{
    const ss_model_plan *plan = &body->plan;
    softsim_status status = allocate(body);
    body->sigma = body->has_skin ? body->own.skin.sigma : mean_sigma(body);
    if (status != SOFTSIM_OK || body->sigma < 0.0) {
        return SOFTSIM_ERROR_MEMORY;
    }
    if (body->has_skin && plan->friction_by_node) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "contact.friction: the surface that %s touches with is its own and has "
                          "no values by node; give one number",
                          body->own.name);
        return SOFTSIM_ERROR_SCENE;
    }
    status = ss_tools_create(&body->tools, body->skin, plan, error);
    for (int k = 0; status == SOFTSIM_OK && k < SOFTSIM_MAX_PROBES; ++k) {
        if (plan->tool[k].is_used) {
            status = create_tool(body, k);
        }
    }
    return status;
}

void ss_body_set_contact_stiffness(ss_body *body)
{
    const double h = body->own.planned_step;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &body->tools.tool[k];
        if (tool->is_used) {
            const double wanted =
                body->has_skin
                    ? MIN_CONTACT_SHARE
                    : CONTACT_SHARE * ss_surface_mean_edge(body->tools.surface) / tool->radius;
            const double share = fmin(fmax(wanted, MIN_CONTACT_SHARE), MAX_CONTACT_SHARE);
            const double stable = isfinite(h) ? share * body->sigma / (h * h) : (double)INFINITY;
            tool->stiffness = ss_plan_contact_stiffness(&body->plan, stable, tool->radius);
            ss_contact_query_set_stiffness(tool->query, tool->stiffness);
        }
    }
}

void ss_body_tools_reset(ss_body *body)
{
    body->fitted_step = -1;
    ss_tools_reset(&body->tools);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_body_touch *felt = &body->felt[k];
        felt->viscosity = felt->swift = 0.0;
        felt->age = 0;
        if (body->tools.tool[k].is_used) {
            memset(felt->shape_y, 0, ss_body_bytes(body));
            memset(felt->shape_step, 0, ss_body_bytes(body));
        }
    }
}

/* ---- on the way ---- */

/* The contact surface at the displacements that a step begins or ends with. Once for both: the end
 * of one is the beginning of the next. */
static void refit(ss_body *body, const ss_real *u)
{
    ss_surface_refit(body->tools.surface, u);
    body->fitted_step = body->step;
}

/* Finds what the tools may reach from `path` on; returns the number of triangles. Tissue that was
 * out of reach may come near a tool at rest: each step looks at all nodes, its sub-steps at those
 * in reach, for the broad phase's margin is more than the others move in a step. */
static int32_t update_broad_phase(ss_body *body, const ss_real *u, double path)
{
    int32_t count = 0;
    bool is_refitted = false;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &body->tools.tool[k];
        if (!tool->is_present) {
            continue;
        }
        ss_tool_pose from;
        ss_tool_at(tool, path, &from);
        if (!is_refitted && (body->fitted_step != body->step ||
                             !ss_contact_query_is_covered(tool->query, u, &from, &tool->to))) {
            refit(body, u);
            is_refitted = true;
        }
        count += ss_contact_query_broad_phase(tool->query, u, &from, &tool->to);
    }
    return count;
}

static const ss_real *lay_skin(ss_body *body, const ss_real *u)
{
    if (body->has_skin) {
        body->own.skin.lay(body->own.elastic.owner, u, body->skin_u);
    }
    return ss_body_skin_u(body, u);
}

const ss_real *ss_body_refit(ss_body *body)
{
    const ss_real *u = lay_skin(body, body->nodes.u);
    if (body->fitted_step != body->step) {
        refit(body, u);
    }
    return u;
}

void ss_body_take_tools(ss_body *body, const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *own = &body->tools.tool[k];
        if (ss_tool_take(own, tool ? &tool[k] : NULL) != SS_TOOL_KEPT) {
            body->is_ready = false;
        }
        if (!own->is_present) {
            own->was_touching = false;
            own->penalty = 0.0;
        }
    }
}

void ss_body_take_grasps(ss_body *body, const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *own = &body->tools.tool[k];
        if (!own->is_present) {
            continue;
        }
        const bool is_holding =
            ss_grasp_follow_button(&own->grasp, tool[k].is_grasping, own->force);
        if (is_holding && !own->grasp.is_pressed) {
            const int32_t *node;
            const double *weight;
            double total;
            const ss_real *u = lay_skin(body, body->nodes.u);
            update_broad_phase(body, u, 0.0);
            if (own->grasp.count > 0) { /* still letting go: what is left is lost at once */
                own->grasp.count = 0;
                body->is_ready = false;
            }
            const int32_t count =
                ss_contact_query_weigh(own->query, u, body->has_skin ? NULL : body->is_source,
                                       &own->pose, &node, &weight, &total);
            ss_grasp_take(&own->grasp, count, node, weight,
                          SS_GRASP_STIFFNESS_RATIO * own->stiffness, body->tools.rest, u,
                          &own->pose);
        }
        own->grasp.is_pressed = is_holding;
    }
}

int32_t ss_body_motion_steps(ss_body *body)
{
    const double steps = ss_tools_parts(&body->tools);
    if (steps > 1.0 && update_broad_phase(body, lay_skin(body, body->nodes.u), 0.0) == 0) {
        return 1;
    }
    return (int32_t)fmin(steps, (double)body->plan.max_substeps);
}

bool ss_body_has_contact(const ss_body *body)
{
    return ss_tools_is_any(&body->tools);
}

/* Skin forces of the `count` nodes go to the body's and are cleared. */
static void carry(ss_body *body, int32_t count, const int32_t *node, ss_real *force)
{
    body->own.skin.carry(body->own.elastic.owner, count, node, body->skin_force, force);
    for (int32_t i = 0; i < count; ++i) {
        memset(body->skin_force + 4 * (ptrdiff_t)node[i], 0, 4 * sizeof *body->skin_force);
    }
}

void ss_body_add_contact(ss_body *body, const ss_real *u, double path, ss_real *force)
{
    if (!ss_body_has_contact(body)) {
        return;
    }
    const ss_real *skin_u = lay_skin(body, u);
    ss_real *target = body->has_skin ? body->skin_force : force;
    update_broad_phase(body, skin_u, path);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &body->tools.tool[k];
        if (!tool->is_present) {
            continue;
        }
        ss_tool_at(tool, path, &tool->pose);
        ss_tools_press(&body->tools, tool, skin_u, target, target);
        if (body->has_skin) {
            const int32_t *node;
            const int32_t count = ss_contact_query_candidate_nodes(tool->query, &node);
            carry(body, count, node, force);
            carry(body, tool->grasp.count, tool->grasp.node, force);
        }
    }
}

/* ---- stiffness ---- */

/* The contact's and the grasp's rows of one tool onto skin_stiff; then to `diagonal`, clearing. */
static void add_tool_diagonal(ss_body *body, const ss_tool *tool, double *diagonal)
{
    const int32_t *node;
    const int32_t count = ss_contact_query_candidate_nodes(tool->query, &node);
    ss_tool_add_diagonal(tool, body->skin_stiff);
    for (int part = 0; part < 2; ++part) {
        const int32_t *list = part == 0 ? node : tool->grasp.node;
        const int32_t length = part == 0 ? count : tool->grasp.count;
        if (body->has_skin) {
            body->own.skin.carry_diagonal(body->own.elastic.owner, length, list, body->skin_stiff,
                                          diagonal);
        }
        for (int32_t i = 0; i < length; ++i) {
            if (!body->has_skin) { /* a skin has more nodes than the body */
                diagonal[list[i]] += body->skin_stiff[list[i]];
            }
            body->skin_stiff[list[i]] = 0.0;
        }
    }
}

void ss_body_contact_diagonal(ss_body *body, double *diagonal)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (body->tools.tool[k].is_present) {
            add_tool_diagonal(body, &body->tools.tool[k], diagonal);
        }
    }
}

/* Stiffness of all tools and grasps onto skin_stiff, the nodes that have any into stiff_node. */
static int32_t list_stiff(ss_body *body)
{
    int32_t count = 0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (body->tools.tool[k].is_present) {
            ss_tool_add_diagonal(&body->tools.tool[k], body->skin_stiff);
        }
    }
    for (int k = 0; k < 2 * SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &body->tools.tool[k / 2];
        const int32_t *node = tool->grasp.node;
        const int32_t length = !tool->is_present ? 0
                               : k % 2 == 0 ? ss_contact_query_candidate_nodes(tool->query, &node)
                                            : tool->grasp.count;
        for (int32_t i = 0; i < length; ++i) {
            if (body->skin_stiff[node[i]] > 0.0 && !body->is_stiff[node[i]]) {
                body->is_stiff[node[i]] = 1;
                body->stiff_node[count++] = node[i];
            }
        }
    }
    return count;
}

double ss_body_contact_rate2(ss_body *body)
{
    const ss_body_skin *skin = &body->own.skin;
    const ss_real *mobility = body->nodes.mobility;
    bool is_held = false;
    double largest = 0.0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        is_held = is_held || body->tools.tool[k].grasp.count > 0;
    }
    if (!is_held && (!ss_body_has_contact(body) || ss_tools_energy(&body->tools) == 0.0)) {
        return 0.0;
    }
    const int32_t count = list_stiff(body);
    if (body->has_skin) {
        largest = skin->rate2(body->own.elastic.owner, count, body->stiff_node, body->skin_stiff,
                              mobility);
    }
    for (int32_t i = 0; i < count; ++i) {
        const int32_t node = body->stiff_node[i];
        if (!body->has_skin) {
            const ss_real *light = mobility + 4 * (ptrdiff_t)node;
            const double most = fmax(fmax((double)light[0], (double)light[1]), (double)light[2]);
            largest = fmax(largest, most * body->skin_stiff[node]);
        }
        body->skin_stiff[node] = 0.0;
        body->is_stiff[node] = 0;
    }
    return largest;
}

void ss_body_contact_tangent(ss_body *body, const ss_real *x, ss_real *out)
{
    if (!ss_body_has_contact(body)) {
        return;
    }
    /* The motion of the skin is linear in that of the nodes, so that `lay` serves both. */
    const ss_real *skin_x = lay_skin(body, x);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &body->tools.tool[k];
        if (!tool->is_present) {
            continue;
        }
        const int32_t *node;
        const int32_t count = ss_contact_query_candidate_nodes(tool->query, &node);
        ss_tool_add_change(tool, skin_x, body->skin_force);
        for (int part = 0; part < 2; ++part) {
            const int32_t *list = part == 0 ? node : tool->grasp.node;
            const int32_t length = part == 0 ? count : tool->grasp.count;
            for (int32_t i = 0; i < length; ++i) {
                ss_real *f = body->skin_force + 4 * (ptrdiff_t)list[i];
                for (int a = 0; a < 3; ++a) {
                    f[a] = -f[a]; /* the force's change, turned into stiffness times motion */
                }
                if (!body->has_skin) {
                    for (int a = 0; a < 3; ++a) {
                        out[4 * (ptrdiff_t)list[i] + a] += f[a];
                    }
                    memset(f, 0, 4 * sizeof *f);
                }
            }
            if (body->has_skin) {
                carry(body, length, list, out);
            }
        }
    }
}

void ss_body_external(ss_body *body, const ss_real *u, double path)
{
    memcpy(body->nodes.force, body->load_force, ss_body_bytes(body));
    ss_body_add_contact(body, u, path, body->nodes.force);
    body->has_elastic = false;
}

double ss_body_path_start(const ss_body *body)
{
    return body->path;
}
