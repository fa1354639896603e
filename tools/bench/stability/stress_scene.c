/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/stress_scene.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include "rt/random.h"

/* s: 1 / 14 at 10 kPa, the first shear mode of the specimen, damped about critically. */
static const double tau_10kpa_s = 0.0714;
/* Shares of E L^2: the load of most runs. In units of tau: when loads are full, let go, ended. */
static const double usual_load = 0.005;
static const double ramp_tau = 2.0, release_tau = 4.0, end_tau = 10.0;
static const double ticks_per_tau = 50.0;
/* What a body may do by itself, in sizes, and over the displacement of a linear one. */
static const double reach_sizes = 17.0, reach_linear = 20.0;
/* s: the tool presses, and stays where it jumped; the haptic loop's own times. */
static const double tool_wait_s = 0.15, jump_wait_s = 0.05, tool_tau_s = 0.01;

/* ---- parts of the scene ---- */

__attribute__((format(printf, 2, 3))) static void add_text(ss_stress_case_plan *plan,
                                                           const char *format, ...)
{
    const size_t used = strlen(plan->more);
    va_list list;
    va_start(list, format);
    vsnprintf(plan->more + used, sizeof plan->more - used, format, list);
    va_end(list);
}

/* "[first, ..., first + count - 1]" */
static void add_nodes(ss_stress_case_plan *plan, int32_t first, int32_t count)
{
    for (int32_t i = 0; i < count; ++i) {
        add_text(plan, "%s%d", i > 0 ? ", " : "[", first + i);
    }
    add_text(plan, "]");
}

static void add_load(ss_stress_case_plan *plan, int32_t first, int32_t count, const double force[3])
{
    ss_stress_case_load *load = &plan->load[plan->load_count];
    *load = (ss_stress_case_load){first, count, {force[0], force[1], force[2]}};
    add_text(plan, "%s  - {nodes: ", plan->load_count == 0 ? "loads:\n" : "");
    add_nodes(plan, first, count);
    add_text(plan, ", force_n: [%.17g, %.17g, %.17g], from_s: 0, ramp_s: %.17g", force[0], force[1],
             force[2], plan->ramp_s);
    if (isfinite(plan->release_s)) {
        add_text(plan, ", to_s: %.17g", plan->release_s);
    }
    add_text(plan, "}\n");
    ++plan->load_count;
}

static void add_places(ss_stress_case_plan *plan, int32_t first, int32_t count, const double u[3],
                       const char *axes)
{
    add_text(plan, "  - {nodes: ");
    add_nodes(plan, first, count);
    add_text(plan, ", displacement_m: [%.17g, %.17g, %.17g], from_s: 0, ramp_s: %.17g, axes: %s}\n",
             u[0], u[1], u[2], plan->ramp_s, axes);
}

/* A force on the top, or on one node, of `newtons`, a little aslant. */
static void push(ss_stress_case_plan *plan, double newtons, bool is_one_node)
{
    const double force[3] = {0.28 * newtons, 0.1 * newtons, -0.95 * newtons};
    const double stiffness = plan->trial->stiffness_pa;
    const double across = is_one_node ? SS_SPECIMEN_SIZE / SS_SPECIMEN_CELLS : SS_SPECIMEN_SIZE;
    add_load(plan, is_one_node ? SS_STRESS_CASE_TOP_CENTRE : SS_SPECIMEN_TOP,
             is_one_node ? 1 : SS_SPECIMEN_LAYER, force);
    plan->reach_m += reach_linear * newtons / (stiffness * across);
}

static void drive_top(ss_stress_case_plan *plan, double x, double z)
{
    const double u[3] = {x, 0.0, z};
    plan->drive = SS_STRESS_CASE_PLACES;
    plan->release_s = (double)INFINITY;
    plan->reach_m += 2.0 * hypot(x, z);
    add_text(plan, "prescribed:\n");
    add_places(plan, SS_SPECIMEN_TOP, SS_SPECIMEN_LAYER, u, "xyz");
}

static void use_tool(ss_stress_case_plan *plan)
{
    const double newtons = fmin(
        fmax(0.01 * plan->trial->stiffness_pa * SS_SPECIMEN_SIZE * SS_SPECIMEN_SIZE, 1e-3), 100.0);
    plan->drive = SS_STRESS_CASE_TOOL;
    plan->step_s = 0.0;
    if (plan->trial->kind ==
        SS_STRESS_CASE_SPIN) { /* a box: what turns must have a shape that does */
        const double edge_mm = 2e3 * SS_STRESS_CASE_TOOL_RADIUS;
        add_text(plan,
                 "contact:\n  tools: [{probe: 0, shape: {box: {size_mm: [%.9g, %.9g, %.9g]}}}]\n",
                 edge_mm, 0.6 * edge_mm, edge_mm);
    } else {
        add_text(plan, "contact:\n  tools: [{probe: 0, shape: {sphere: {radius_mm: %.9g}}}]\n",
                 1e3 * SS_STRESS_CASE_TOOL_RADIUS);
    }
    add_text(plan, "  working_force_n: %.9g\nhaptic: {max_jump_m: %.9g, max_force_n: %.9g}\n",
             newtons, plan->max_jump_m, SS_STRESS_CASE_MAX_FORCE);
}

/* ---- tangled ---- */

/* Every other node of the surface above the bottom is pushed, or put, somewhere at random. */
static void tangle(ss_stress_case_plan *plan)
{
    const ss_stress_case *trial = plan->trial;
    const double edge = SS_SPECIMEN_SIZE / SS_SPECIMEN_CELLS;
    const bool is_places = trial->variant >= 3;
    const double size = trial->value * (is_places ? edge : trial->stiffness_pa * edge * edge);
    uint64_t state = 12345u + (uint64_t)trial->variant;
    plan->ramp_s = 0.0;
    if (is_places) {
        plan->drive = SS_STRESS_CASE_PLACES;
        plan->release_s = (double)INFINITY;
        add_text(plan, "prescribed:\n");
    }
    for (int32_t i = SS_SPECIMEN_LAYER; i < SS_SPECIMEN_NODES; ++i) {
        double x[3];
        for (int k = 0; k < 3; ++k) {
            x[k] = size * ss_random_signed(&state);
        }
        if (ss_random_signed(&state) < 0.0 || !ss_specimen_is_surface(i)) {
            continue; /* not every model has something inside */
        }
        if (is_places) {
            add_places(plan, i, 1, x, "xyz");
        } else {
            add_load(plan, i, 1, x);
        }
    }
    plan->reach_m +=
        is_places ? 4.0 * size : reach_linear * SS_SPECIMEN_NODES * trial->value * edge;
}

/* ---- contradictions ---- */

static void contradict(ss_stress_case_plan *plan)
{
    const double newtons =
        usual_load * plan->trial->stiffness_pa * SS_SPECIMEN_SIZE * SS_SPECIMEN_SIZE;
    const double up[3] = {0.0, 0.0, 0.005}, down[3] = {0.0, 0.0, -0.005};
    const double force[3] = {0.0, 0.0, -newtons};
    plan->reach_m += 0.02;
    switch (plan->trial->variant) {
    case 0: /* everything is fixed (write_fixed), and pushed */
        push(plan, newtons, false);
        break;
    case 1: /* fixed nodes are put somewhere else */
        drive_top(plan, 0.0, -0.005);
        add_places(plan, 0, 3, up, "xyz");
        break;
    case 2: /* two places for one node */
        drive_top(plan, 0.0, -0.005);
        add_places(plan, SS_STRESS_CASE_TOP_CENTRE, 1, up, "xyz");
        break;
    case 3: /* a load on fixed nodes alone */
        add_load(plan, 0, SS_SPECIMEN_LAYER, force);
        break;
    case 4: /* a load on prescribed nodes */
        drive_top(plan, 0.0, -0.005);
        add_load(plan, SS_SPECIMEN_TOP, SS_SPECIMEN_LAYER, force);
        break;
    case 5: /* every node is prescribed, as a rigid body */
        add_text(plan, "prescribed:\n");
        add_places(plan, SS_SPECIMEN_LAYER, SS_SPECIMEN_NODES - SS_SPECIMEN_LAYER, up, "xyz");
        plan->drive = SS_STRESS_CASE_PLACES;
        break;
    case 6: /* one set drives along x, another along z: no contradiction */
        add_text(plan, "prescribed:\n");
        add_places(plan, SS_SPECIMEN_TOP, SS_SPECIMEN_LAYER, up, "x");
        add_places(plan, SS_SPECIMEN_TOP, SS_SPECIMEN_LAYER, down, "z");
        plan->drive = SS_STRESS_CASE_PLACES;
        break;
    case 7: /* both for the same axis */
        add_text(plan, "prescribed:\n");
        add_places(plan, SS_SPECIMEN_TOP, SS_SPECIMEN_LAYER, up, "xz");
        add_places(plan, SS_SPECIMEN_TOP, SS_SPECIMEN_LAYER, down, "z");
        plan->drive = SS_STRESS_CASE_PLACES;
        break;
    case 8: /* the tool stands inside the body from the start */
    case 9: /* the tool is pushed through the fixed bottom */
        use_tool(plan);
        break;
    default: /* a force on a body that one node holds: a hinge, with far to swing */
        push(plan, 0.1 * newtons, false);
        break;
    }
    if (plan->drive == SS_STRESS_CASE_PLACES) {
        plan->release_s = (double)INFINITY;
    }
}

/* Which nodes are held. */
static void write_fixed(const ss_stress_case_plan *plan, FILE *file)
{
    const bool is_all =
        plan->trial->kind == SS_STRESS_CASE_CONTRADICTION && plan->trial->variant == 0;
    const bool is_one = plan->trial->kind == SS_STRESS_CASE_CONTRADICTION &&
                        plan->trial->variant == SS_STRESS_CASE_CONTRADICTIONS - 1;
    const int32_t count = is_all ? SS_SPECIMEN_NODES : is_one ? 1 : SS_SPECIMEN_LAYER;
    fputs("  fixed: [{nodes: [", file);
    for (int32_t i = 0; i < count; ++i) {
        fprintf(file, "%s%d", i > 0 ? ", " : "", i);
    }
    fputs("]}]\n", file);
}

/* ---- the tool's path ---- */

/* Down onto the top at `speed` until the sphere is `depth` in it, and later up again. */
static void plan_path(ss_stress_case_plan *plan)
{
    const ss_stress_case *trial = plan->trial;
    if (ss_stress_case_is_abuse(trial->kind)) {
        ss_stress_case_abuse_plan(plan);
        return;
    }
    const bool is_inside = trial->kind == SS_STRESS_CASE_CONTRADICTION && trial->variant == 8;
    const bool is_through = trial->kind == SS_STRESS_CASE_CONTRADICTION && trial->variant == 9;
    const double speed = trial->kind == SS_STRESS_CASE_PROBE ? trial->value
                         : is_through                        ? 0.5
                                                             : 0.2;
    const double depth = is_through                               ? 1.3 * SS_SPECIMEN_SIZE
                         : is_inside                              ? 0.5 * SS_SPECIMEN_SIZE
                         : trial->kind == SS_STRESS_CASE_TELEPORT ? 0.005
                                                                  : 0.01;
    const double top =
        plan->specimen.rest[SS_STRESS_CASE_TOP_CENTRE][2] + SS_STRESS_CASE_TOOL_RADIUS;
    const double free = top + 0.03, down = top - depth;
    const double way_s = (free - down) / speed;
    ss_stress_case_plan_go(plan, 0.0, 0.0, is_inside ? down : free);
    ss_stress_case_plan_go(plan, is_inside ? tool_wait_s : way_s, 0.0, down);
    ss_stress_case_plan_go(plan, trial->kind == SS_STRESS_CASE_TELEPORT ? jump_wait_s : tool_wait_s,
                           0.0, down);
    if (trial->kind == SS_STRESS_CASE_TELEPORT) {
        const double x = trial->value * SS_SPECIMEN_SIZE;
        ss_stress_case_plan_go(plan, 0.0, x, down);
        ss_stress_case_plan_go(plan, jump_wait_s, x, down);
        ss_stress_case_plan_go(plan, 0.0, 0.0, down);
        ss_stress_case_plan_go(plan, jump_wait_s, 0.0, down);
    }
    ss_stress_case_plan_go(plan, way_s, 0.0, free);
}

void ss_stress_case_plan_tool(const ss_stress_case_plan *plan, double time_s, int32_t tick,
                              double out_position[3], double out_orientation[4])
{
    static const double upright[4] = {1.0, 0.0, 0.0, 0.0};
    ss_stress_case_plan_at(plan, time_s, out_position);
    memcpy(out_orientation, upright, sizeof upright);
    ss_stress_case_abuse(plan, time_s, tick, out_position, out_orientation);
}

/* ---- the plan ---- */

static void plan_kind(ss_stress_case_plan *plan)
{
    const ss_stress_case *trial = plan->trial;
    const double area = SS_SPECIMEN_SIZE * SS_SPECIMEN_SIZE;
    const double newtons = usual_load * trial->stiffness_pa * area;
    switch (trial->kind) {
    case SS_STRESS_CASE_CONTROL:
    case SS_STRESS_CASE_STIFFNESS:
        if (trial->variant == 1) {
            use_tool(plan);
        } else if (trial->variant == 2) {
            drive_top(plan, 0.0, -0.05 * SS_SPECIMEN_SIZE);
        } else {
            push(plan, newtons, false);
        }
        break;
    case SS_STRESS_CASE_TELEPORT:
        plan->max_jump_m = trial->variant == 1 ? 10.0 : 0.05;
        if (trial->variant == 2) {
            plan->ramp_s = 0.0;
            drive_top(plan, trial->value * SS_SPECIMEN_SIZE, 0.0);
        } else {
            use_tool(plan);
        }
        break;
    case SS_STRESS_CASE_THROUGH:
        plan->max_jump_m = trial->variant > 0 ? 10.0 : 0.05;
        use_tool(plan);
        break;
    case SS_STRESS_CASE_PROBE:
    case SS_STRESS_CASE_NOISE:
    case SS_STRESS_CASE_IN_OUT:
    case SS_STRESS_CASE_SPIN:
    case SS_STRESS_CASE_PAUSE:
        use_tool(plan);
        break;
    case SS_STRESS_CASE_FORCE:
        push(plan, trial->value, true);
        break;
    case SS_STRESS_CASE_TANGLED:
        tangle(plan);
        break;
    case SS_STRESS_CASE_FLATTENED:
        plan->ramp_s = 0.0;
        if (trial->variant == 1) {
            drive_top(plan, 0.0, (trial->value - 1.0) * SS_SPECIMEN_SIZE);
        } else {
            push(plan, trial->value * trial->stiffness_pa * area, false);
        }
        break;
    case SS_STRESS_CASE_CONTRADICTION:
        contradict(plan);
        break;
    default:
        push(plan, newtons, false);
        break;
    }
}

void ss_stress_case_plan_make(const ss_stress_case *trial, ss_stress_case_plan *out)
{
    const double tau = fmax(tau_10kpa_s * sqrt(1e4 / trial->stiffness_pa),
                            ss_stress_case_own_time(trial->subject));
    *out = (ss_stress_case_plan){.trial = trial,
                                 .drive = SS_STRESS_CASE_LOADS,
                                 .tau_s = tau,
                                 .step_s = tau / ticks_per_tau,
                                 .ramp_s = ramp_tau * tau,
                                 .release_s = release_tau * tau,
                                 .end_s = end_tau * tau,
                                 .reach_m = reach_sizes * SS_SPECIMEN_SIZE,
                                 .max_substeps = trial->kind == SS_STRESS_CASE_SUBSTEP ? 1 : 64,
                                 .max_jump_m = 0.05};
    ss_specimen_make(trial->kind == SS_STRESS_CASE_SLIVER ? trial->value : 1.0, &out->specimen);
    plan_kind(out);
    if (trial->kind == SS_STRESS_CASE_STEP || trial->kind == SS_STRESS_CASE_SUBSTEP ||
        trial->kind == SS_STRESS_CASE_STIFFNESS) {
        out->step_s = 0.0;
    }
    if (out->drive == SS_STRESS_CASE_TOOL) {
        plan_path(out);
        out->release_s = out->way_s[out->way_count - 1] + tool_wait_s;
        out->end_s = out->release_s + (end_tau - release_tau) * fmax(out->tau_s, tool_tau_s);
    }
}

void ss_stress_case_plan_write(const ss_stress_case_plan *plan, FILE *file)
{
    fputs("softsim: 1\nobject:\n  mesh: body.msh\n  units: m\n", file);
    write_fixed(plan, file);
    ss_stress_case_subject_write(plan->trial, file);
    fprintf(file, "simulation: {%smax_substeps: %d, sleep: off}\npublish: {mesh_rate_hz: 0}\n%s",
            plan->step_s > 0.0 ? "" : "rate_hz: 1000, ", plan->max_substeps, plan->more);
}
