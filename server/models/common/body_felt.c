/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/body_state.h"
/*
 * How stiff a body feels to a tool that presses along n: the contact's own stiffness in series
 * with the body's. With c the force on the nodes and k_cc that on the tool for a unit motion of the
 * tool, K the law's tangent, C the contact's and grasps',
 *
 *   H = K + C + M / tau^2,   k(y) = k_cc - 2 c.y + y.H y  >=  k_cc - c.H^-1 c  for any motion y,
 *
 * with equality at H y = c. y is kept between steps and improved by a part along the displacement
 * and one step of Jacobi-preconditioned conjugate gradients that go on from call to call, so that
 * the estimate costs a few products, depends on nothing but the past, and errs high: a stiffness
 * that is too low makes the haptic loop unstable; one that is too high lets a moving tool feel less
 * or more than the body answers, until results say otherwise. M / tau^2, the inertia over tau
 * = 50 ms, errs high too; it is what a body without supports answers with at all, and changes
 * little where there are some. It is improved in every step while a contact is young, then every
 * fourth: a product costs as much as a sub-step. A step of many sub-steps has moved the contact
 * far, and pays for as many iterations as make it good. Where K is not positive along a search
 * direction (a buckled body) the estimate stays as it was. Rejected: an exact solve (a factor a
 * step), the secant (too low).
 *
 * Tangentially the body answers with the same H: k_t = k_n. The viscosity is the damping that y
 * meets, alpha M and viscous_time K, at most 10 ms of stiffness.
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

/* Conjugate gradients in a new contact, after a jump, and at rest; calls in which a contact is
 * young, and calls from one improvement to the next afterwards; sub-steps of a long step for each
 * iteration; of the swift stiffness, calls at first and from one to the next, and iterations. */
enum {
    FIRST_ITERATIONS = 6,
    AGAIN_ITERATIONS = 12,
    REST_ITERATIONS = 200,
    ROUND = 10,
    YOUNG = 8,
    EVERY = 4,
    SUBSTEPS = 4,
    SWIFT_YOUNG = 4,
    SWIFT_EVERY = 16,
    SWIFT_ITERATIONS = 4
};
/* From one estimate to the next: more, and the body answers otherwise than before (a wall that
 * snaps back); the contact is young again. Improved as usual, the wall of hm1 on a tool's way out
 * was felt nine times too stiff, and the force, as the tool moved, fell to a tenth within 4 ms. */
#define JUMP 2.0
/* Of the compliance at rest, what a round of iterations adds when it is the last: what was left was
 * 1.4 % on a block of 88,000 tetrahedra, 0.6 % and less on all others that were tried. A hand
 * just notices 7 % of a force. */
#define REST_SHARE 5e-3
/* s: of the inertia, and viscosity over stiffness at most. */
#define INERTIA_TIME     0.05
#define MAX_VISCOUS_TIME 0.01
/* Sine squared, by H, below which two directions are one. */
#define LEAST_ANGLE 1e-6

/* out = (K + M / tau^2) x on the axes that may move. */
static void apply_law(ss_body *body, const ss_real *x, ss_real *out)
{
    const ss_body_nodes *nodes = &body->nodes;
    for (int32_t i = 0; i < nodes->padded_count; ++i) {
        const ss_real inertia = (ss_real)(nodes->mass[i] * body->solver.rate2);
        for (ptrdiff_t at = 4 * (ptrdiff_t)i; at < 4 * (ptrdiff_t)i + 4; ++at) {
            out[at] = inertia * x[at];
        }
    }
    body->own.elastic.tangent(body->own.elastic.owner, x, out);
}

static void apply(ss_body *body, const ss_real *x, ss_real *out)
{
    apply_law(body, x, out);
    ss_body_contact_tangent(body, x, out);
}

/* Rows of the Jacobi preconditioner: 0 on axes that cannot move. */
static void set_inverse(ss_body *body)
{
    const ss_body_nodes *nodes = &body->nodes;
    memset(body->contact_stiff, 0, (size_t)nodes->padded_count * sizeof *body->contact_stiff);
    ss_body_contact_diagonal(body, body->contact_stiff);
    for (int32_t i = 0; i < nodes->count; ++i) {
        const double stiff =
            body->solver.stiff[i] + body->contact_stiff[i] + nodes->mass[i] * body->solver.rate2;
        const ss_real inverse = stiff > 0.0 ? (ss_real)(1.0 / stiff) : 0;
        for (ptrdiff_t at = 4 * (ptrdiff_t)i; at < 4 * (ptrdiff_t)i + 4; ++at) {
            body->solver.inverse[at] = nodes->mobility[at] > 0 ? inverse : 0;
        }
    }
}

static void precondition(const ss_body *body)
{
    const ss_body_solver *solver = &body->solver;
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)body->nodes.padded_count; ++at) {
        solver->scaled[at] = solver->inverse[at] * solver->residual[at];
    }
}

/* y and the residual as good as a part along the body's own displacement makes them: what a tool
 * has pressed so far is much like what it presses next, all over the body, where conjugate
 * gradients get in many steps only. */
static void follow_displacement(ss_body *body, ss_real *y)
{
    ss_body_solver *solver = &body->solver;
    const int32_t n = body->nodes.padded_count;
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)n; ++at) {
        solver->search[at] = body->nodes.mobility[at] > 0 ? body->nodes.u[at] : 0;
    }
    apply(body, solver->search, solver->product);
    const double curvature = ss_body_dot(n, solver->search, solver->product);
    const double share = ss_body_dot(n, solver->search, solver->residual) / curvature;
    if (curvature > 0.0 && isfinite(share)) {
        ss_body_axpy(n, share, solver->search, y);
        ss_body_axpy(n, -share, solver->product, solver->residual);
    }
}

/* The residual push - H y into solver.residual. */
static void set_residual(ss_body *body, const ss_real *y)
{
    ss_body_solver *solver = &body->solver;
    apply(body, y, solver->product);
    ss_body_blend(body->nodes.padded_count, solver->push, -1.0, solver->product, solver->residual);
}

/* Improves y towards H y = push, and the residual with it, until a round of iterations adds less
 * than `share` to the compliance y.push. */
static void solve_some(ss_body *body, ss_real *y, int iterations, double share)
{
    ss_body_solver *solver = &body->solver;
    const int32_t n = body->nodes.padded_count;
    precondition(body);
    memcpy(solver->search, solver->scaled, ss_body_bytes(body));
    double rho = ss_body_dot(n, solver->residual, solver->scaled);
    /* Beyond the precision of the scalars there is nothing left to improve. */
    const double enough = rho * (sizeof *y == sizeof(float) ? 1e-13 : 1e-26);
    double total = 0.0, round = 0.0;
    for (int k = 0; k < iterations && rho > enough; ++k) {
        if (k % ROUND == 0 && k > 0) {
            if (round < share * total) {
                break;
            }
            round = 0.0;
        }
        apply(body, solver->search, solver->product);
        /* The search has no part along axes that cannot move. */
        const double curvature = ss_body_dot(n, solver->search, solver->product);
        if (!(curvature > 0.0)) {
            break;
        }
        round += rho * rho / curvature;
        total += rho * rho / curvature;
        ss_body_axpy(n, rho / curvature, solver->search, y);
        ss_body_axpy(n, -rho / curvature, solver->product, solver->residual);
        precondition(body);
        const double next = ss_body_dot(n, solver->residual, solver->scaled);
        ss_body_blend(n, solver->scaled, next / rho, solver->search, solver->search);
        rho = next;
    }
}

/* One step of conjugate gradients more than the calls before it made, though H and the push have
 * moved since: least over the preconditioned residual and the step before together, which is
 * conjugate gradients where nothing moved. Each call for itself would be steepest descent, which
 * never got there: a ventricle pressed 14 mm deep was felt with 194 N/m for ever, of 55. */
static void solve_on(ss_body *body, const ss_body_touch *felt)
{
    ss_body_solver *solver = &body->solver;
    ss_real *y = felt->shape_y, *step = felt->shape_step;
    const int32_t n = body->nodes.padded_count;
    precondition(body);
    apply(body, solver->scaled, solver->product);
    apply(body, step, solver->search);
    const double zz = ss_body_dot(n, solver->scaled, solver->product);
    const double zp = ss_body_dot(n, step, solver->product);
    const double pp = ss_body_dot(n, step, solver->search);
    const double z = ss_body_dot(n, solver->scaled, solver->residual);
    const double p = ss_body_dot(n, step, solver->residual);
    const double det = zz * pp - zp * zp;
    const bool is_plane = pp > 0.0 && det > LEAST_ANGLE * zz * pp;
    const double by_z = is_plane ? (z * pp - p * zp) / det : z / zz;
    const double by_p = is_plane ? (p * zz - z * zp) / det : 0.0;
    if (!(zz > 0.0) || !isfinite(by_z) || !isfinite(by_p)) {
        return;
    }
    ss_body_blend(n, step, by_p - 1.0, step, step);
    ss_body_axpy(n, by_z, solver->scaled, step);
    ss_body_axpy(n, 1.0, step, y);
    ss_body_axpy(n, -by_z, solver->product, solver->residual);
    ss_body_axpy(n, -by_p, solver->search, solver->residual);
}

/* ---- in contact ---- */

/* The forces on the contact surface's nodes go into solver.push and are cleared. */
static void carry_push(ss_body *body, int32_t count, const int32_t *node)
{
    ss_real *push = body->solver.push;
    if (body->has_skin) {
        body->own.skin.carry(body->own.elastic.owner, count, node, body->skin_force, push);
    } else {
        for (int32_t i = 0; i < count; ++i) {
            for (ptrdiff_t at = 4 * (ptrdiff_t)node[i]; at < 4 * (ptrdiff_t)node[i] + 3; ++at) {
                push[at] += body->skin_force[at];
                body->skin_force[at] = 0;
            }
        }
    }
    for (int32_t i = 0; i < count; ++i) {
        memset(body->skin_force + 4 * (ptrdiff_t)node[i], 0, 4 * sizeof *body->skin_force);
    }
}

/* c into solver.push; returns k_cc. */
static double push_along(ss_body *body, const ss_tool *tool, const double normal[3])
{
    const int32_t *node;
    const int32_t count = ss_contact_query_candidate_nodes(tool->query, &node);
    memset(body->solver.push, 0, ss_body_bytes(body));
    const double stiffness = ss_tool_push(tool, normal, body->skin_force);
    carry_push(body, count, node);
    carry_push(body, tool->grasp.count, tool->grasp.node);
    return stiffness;
}

/* sum alpha m |y|^2 + viscous_time y.K y */
static double damping_met(ss_body *body, const ss_real *y)
{
    const double viscous = body->own.elastic.viscous_time;
    double mass = 0.0;
    for (int32_t i = 0; body->own.mass_damping > 0.0 && i < body->nodes.count; ++i) {
        const ss_real *p = y + 4 * (ptrdiff_t)i;
        mass += body->nodes.mass[i] * (double)(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    }
    double stiff = 0.0;
    if (viscous > 0.0) {
        memset(body->solver.product, 0, ss_body_bytes(body));
        body->own.elastic.tangent(body->own.elastic.owner, y, body->solver.product);
        stiff = fmax(0.0, ss_body_dot(body->nodes.padded_count, y, body->solver.product));
    }
    return body->own.mass_damping * mass + viscous * stiff;
}

/* k(y): H y = c - residual, hence k_cc - y.(c + residual). */
static double estimate(const ss_body *body, double k_cc, const ss_real *y)
{
    const int32_t n = body->nodes.padded_count;
    return k_cc - ss_body_dot(n, y, body->solver.push) - ss_body_dot(n, y, body->solver.residual);
}

/* k(y) with the inertia over half a step in place of tau: what answers within a step is near the
 * tool, and a few iterations find it. solver.push is c. */
static double swift_stiffness(ss_body *body, double k_cc)
{
    ss_real *y = body->solver.swift;
    const double time = 0.5 * body->plan.step;
    body->solver.rate2 = 1.0 / (time * time);
    memset(y, 0, ss_body_bytes(body));
    set_inverse(body);
    memcpy(body->solver.residual, body->solver.push, ss_body_bytes(body));
    solve_some(body, y, SWIFT_ITERATIONS, 0.0);
    const double swift = estimate(body, k_cc, y);
    body->solver.rate2 = 1.0 / (INERTIA_TIME * INERTIA_TIME);
    return isfinite(swift) ? fmax(0.0, swift) : 0.0;
}

/* Improves felt and viscosity of tool `probe` for a push along `normal`. */
static void feel(ss_body *body, int probe, const double normal[3])
{
    ss_tool *tool = &body->tools.tool[probe];
    ss_body_touch *touch = &body->felt[probe];
    if (!tool->was_touching) {
        memset(touch->shape_y, 0, ss_body_bytes(body));
        memset(touch->shape_step, 0, ss_body_bytes(body));
        touch->age = 0;
    }
    const int iterations = body->substeps / SUBSTEPS;
    const bool is_long = iterations > FIRST_ITERATIONS;
    const bool is_due = is_long || touch->age < YOUNG || touch->age % EVERY == 0;
    ++touch->age;
    if (!is_due) {
        return;
    }
    const double k_cc = push_along(body, tool, normal);
    set_inverse(body);
    set_residual(body, touch->shape_y);
    follow_displacement(body, touch->shape_y);
    if (is_long) {
        solve_some(body, touch->shape_y, iterations, 0.0);
        memset(touch->shape_step, 0, ss_body_bytes(body));
    } else if (tool->was_touching) {
        solve_on(body, touch);
    } else {
        solve_some(body, touch->shape_y, FIRST_ITERATIONS, 0.0);
    }
    double felt = estimate(body, k_cc, touch->shape_y);
    if (tool->was_touching && felt > JUMP * tool->felt) {
        solve_some(body, touch->shape_y, AGAIN_ITERATIONS, 0.0);
        memset(touch->shape_step, 0, ss_body_bytes(body));
        touch->age = 0;
        felt = estimate(body, k_cc, touch->shape_y);
    }
    /* A body that buckles under the tool has no stiffness to tell: what it had goes on. */
    const double last = tool->was_touching && tool->felt > 0.0 ? tool->felt : k_cc;
    const bool is_stiff = isfinite(felt) && felt > 0.0;
    ss_tool_set_felt(tool, is_stiff ? felt : last, k_cc);
    if (!is_stiff) {
        memset(touch->shape_y, 0, ss_body_bytes(body));
        memset(touch->shape_step, 0, ss_body_bytes(body));
    }
    const double viscosity = damping_met(body, touch->shape_y);
    if (touch->age <= SWIFT_YOUNG || touch->age % SWIFT_EVERY == 1) {
        touch->swift = swift_stiffness(body, k_cc);
    }
    touch->viscosity = isfinite(viscosity) ? fmin(viscosity, MAX_VISCOUS_TIME * tool->felt) : 0.0;
}

void ss_body_contacts(ss_body *body, int32_t probe, double near, ss_contact_set *out)
{
    ss_tool *tool = ss_tools_find(&body->tools, probe, out);
    if (!tool || !body->is_ready) {
        return;
    }
    double along[3];
    if (ss_tool_fill_contacts(tool, ss_body_refit(body), near, out, along)) {
        feel(body, probe, along);
        ss_contact_set_share(out, tool->felt, body->felt[probe].viscosity);
        for (int32_t k = 0; k < out->count; ++k) {
            ss_contact *contact = &out->contact[k];
            contact->swift = body->felt[probe].swift * contact->stiffness / tool->felt;
        }
    }
    tool->was_touching = ss_tool_is_touching(tool);
}

void ss_body_slept(ss_body *body, int64_t steps)
{
    const ss_body_elastic *law = &body->own.elastic;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        if (body->tools.tool[k].was_touching) {
            body->felt[k].age += (int32_t)(steps % SWIFT_EVERY);
        }
    }
    if (law->slept) {
        law->slept(law->owner, steps);
    }
}

/* ---- at rest ---- */

/* The node of the contact surface whose area is nearest the mean: neither at the rim nor a special
 * place. */
static int32_t usual_node(const ss_body *body, double *area)
{
    const ss_mesh *mesh = body->skin;
    int32_t best = -1, count = 0;
    double mean = 0.0;
    ss_mesh_node_areas(mesh, area);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        const bool is_free = area[i] > 0.0 && (body->has_skin || body->is_source[i]);
        area[i] = is_free ? area[i] : -1.0;
        mean += is_free ? area[i] : 0.0;
        count += is_free;
    }
    mean = count > 0 ? mean / count : 0.0;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        if (area[i] > 0.0 && (best < 0 || fabs(area[i] - mean) < fabs(area[best] - mean))) {
            best = i;
        }
    }
    return best;
}

/* The push of a contact sample at `node` by the subdivision row's weights: half on the node, half
 * on its ring, along the node's normal. */
static void push_node(ss_body *body, int32_t node)
{
    const ss_mesh *mesh = body->skin;
    double normal[3];
    const int32_t triangles = ss_mesh_node_normal(mesh, node, normal);
    memset(body->solver.push, 0, ss_body_bytes(body));
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        if (c[0] != node && c[1] != node && c[2] != node) {
            continue;
        }
        for (int a = 0; a < 3; ++a) {
            const double weight = c[a] == node ? 0.5 / triangles : 0.25 / triangles;
            for (int k = 0; k < 3; ++k) {
                body->skin_force[4 * (ptrdiff_t)c[a] + k] += (ss_real)(weight * normal[k]);
            }
        }
        carry_push(body, 3, c);
    }
}

softsim_status ss_body_set_rest_felt(ss_body *body)
{
    if (!body->tools.surface) {
        return SOFTSIM_OK;
    }
    body->solver.rate2 = 1.0 / (INERTIA_TIME * INERTIA_TIME);
    double *area = ss_memory_get((size_t)body->skin->node_count, sizeof *area);
    if (!area) {
        return SOFTSIM_ERROR_MEMORY;
    }
    /* The tangent is that of the last forces: those at rest. */
    const ss_body_elastic *law = &body->own.elastic;
    ss_body_energy energy = {0};
    law->force(law->owner, body->nodes.u, body->nodes.v, body->nodes.force, &energy);
    memset(body->nodes.force, 0, ss_body_bytes(body));
    memset(body->solver.stiff, 0, (size_t)body->nodes.padded_count * sizeof(double));
    body->own.elastic.diagonal(body->own.elastic.owner, body->solver.stiff);
    const int32_t node = usual_node(body, area);
    ss_memory_free(area);
    double compliance = 0.0;
    ss_real *y = NULL;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_tool *tool = &body->tools.tool[k];
        if (!tool->is_used) {
            continue;
        }
        if (!y && node >= 0) { /* the body is the same for all tools */
            y = body->felt[k].shape_y;
            push_node(body, node);
            set_inverse(body);
            set_residual(body, y);
            solve_some(body, y, REST_ITERATIONS, REST_SHARE);
            compliance = ss_body_dot(body->nodes.padded_count, y, body->solver.push);
            memset(y, 0, ss_body_bytes(body));
        }
        ss_tool_set_rest_felt(tool, compliance);
    }
    return SOFTSIM_OK;
}
