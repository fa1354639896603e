/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Closed bodies: how far they go under 1 N and whether they come back; and what must not change
 * when a body is moved, renumbered or simulated with another step (section 4.2 of the paper:
 * pairwise forces, fourth-order Runge-Kutta).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/surface_picture.h"
#include "bench/papers/zhong2006/zhong2006.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/order.h"
#include "rt/real.h"
#include "rt/vec.h"

static const double organ_step_s = 0.05, organ_load_s = 200.0, organ_left_s = 450.0;
static const double fixed_share = 0.06; /* of the points, those with the least x */

/* ---- closed organs ---- */

static const struct organ {
    const char *name, *title, *shape, *size_mm;
    int32_t points;
    double scale; /* of the file's lengths in m */
} organs[] = {
    {"organ-642", "ellipsoid of 642 points, 2.4 x 2 x 1.6", "ellipsoid", "2400,2000,1600", 642,
     1.0},
    {"organ-422", "ellipsoid of 422 points, 2.4 x 2 x 1.6", "ellipsoid", "2400,2000,1600", 422,
     1.0},
    {"organ-kidney", "kidney of 642 points, 2.4 long", "kidney", NULL, 642, 2.4 / 0.11},
};
enum { ORGAN_COUNT = sizeof organs / sizeof organs[0] };

/* The fixed list, also as marks, and the node with the greatest x. */
static bool choose_nodes(const ss_trial_body *body, char *fixed, size_t size, uint8_t *is_held,
                         int32_t *out_top)
{
    const int32_t count = (int32_t)(fixed_share * body->node_count + 0.5);
    ss_keyed *order = calloc((size_t)body->node_count, sizeof *order);
    if (order == NULL) {
        return false;
    }
    for (int32_t i = 0; i < body->node_count; ++i) {
        order[i] = (ss_keyed){.key = body->rest[i][0], .index = i};
    }
    qsort(order, (size_t)body->node_count, sizeof *order, ss_compare_keyed);
    *out_top = order[body->node_count - 1].index;
    size_t used = (size_t)snprintf(fixed, size, "[{nodes: [");
    for (int32_t k = 0; k < count; ++k) {
        is_held[order[k].index] = 1;
        used +=
            (size_t)snprintf(fixed + used, size - used, "%s%d", k > 0 ? ", " : "", order[k].index);
    }
    snprintf(fixed + used, size - used, "]}]");
    free(order);
    return true;
}

static double largest(const ss_trial *trial)
{
    double most = 0.0;
    for (int32_t i = 0; i < trial->node_count; ++i) {
        most = fmax(most, ss_norm3(trial->u[i]));
    }
    return most;
}

static double least_extent(const ss_trial_body *body)
{
    double least = (double)INFINITY;
    for (int k = 0; k < 3; ++k) {
        double low = (double)INFINITY, high = -(double)INFINITY;
        for (int32_t i = 0; i < body->node_count; ++i) {
            low = fmin(low, body->rest[i][k]);
            high = fmax(high, body->rest[i][k]);
        }
        least = fmin(least, high - low);
    }
    return least;
}

static softsim_status draw_organ(ss_zhong *zhong, const struct organ *at, const ss_trial_body *body,
                                 const ss_trial *trial, int32_t top, softsim_error *error)
{
    static const ss_surface_picture_view views[2] = {
        {{0.1, -1.0, 0.25}, {0.0, 0.0, 1.0}, "from the side"},
        {{1.0, -0.5, 0.5}, {0.0, 0.0, 1.0}, "from the pushed end"}};
    char caption[200];
    int32_t(*face)[4] = ss_surface_faces(body->triangle_count, (const int32_t(*)[3])body->triangle);
    if (face == NULL) {
        return ss_memory_fault(error);
    }
    const ss_surface_picture shape = {.node_count = body->node_count,
                                      .face_count = body->triangle_count,
                                      .rest = (const double(*)[3])body->rest,
                                      .u = (const double(*)[3])trial->u,
                                      .face = (const int32_t(*)[4])face,
                                      .pushed = top,
                                      .push = {-1.0, 0.0, 0.0}};
    snprintf(caption, sizeof caption, "%s, static under 1 N; dashed: its outline at rest.",
             at->title);
    const softsim_status status =
        ss_surface_picture_draw(zhong->paper, at->name, caption, &shape, views, 2, error);
    free(face);
    return status;
}

/* Depth of the contact as the report's reference network has it; NaN when out of memory. */
static double reference_depth(const ss_trial_body *body, const uint8_t *is_held, int32_t top)
{
    const size_t n = (size_t)body->node_count;
    double *stiffness = calloc(n, sizeof *stiffness), depth = (double)NAN;
    double(*force)[3] = calloc(n, sizeof *force), (*u)[3] = calloc(n, sizeof *u);
    ss_zhong_net *net = ss_zhong_net_triangles(body->node_count, (const double(*)[3])body->rest,
                                               body->triangle_count,
                                               (const int32_t(*)[3])body->triangle, NULL, 0.0);
    if (net != NULL && stiffness != NULL && force != NULL && u != NULL) {
        for (size_t i = 0; i < n; ++i) {
            stiffness[i] = SS_TUBE_KS;
            net->is_held[i] = is_held[i];
        }
        net->is_source[top] = 1;
        force[top][0] = -1.0;
        if (ss_zhong_net_solve(net) && !isnan(ss_zhong_net_static(net, SS_TUBE_MODULUS, stiffness,
                                                                  (const double(*)[3])force, u))) {
            depth = -u[top][0];
        }
    }
    ss_zhong_net_destroy(&net);
    SS_EACH(free, stiffness, force, u);
    return depth;
}

static softsim_status press_organ(ss_zhong *zhong, const struct organ *at,
                                  const ss_trial_body *body, softsim_error *error)
{
    char fixed[1024], loads[160];
    int32_t top = 0;
    ss_trial trial;
    uint8_t *is_held = calloc((size_t)body->node_count, 1);
    const bool is_chosen =
        is_held != NULL && choose_nodes(body, fixed, sizeof fixed, is_held, &top);
    const double reference = is_chosen ? reference_depth(body, is_held, top) : (double)NAN;
    free(is_held);
    if (!is_chosen) {
        return ss_memory_fault(error);
    }
    snprintf(loads, sizeof loads, "loads:\n  - {nodes: [%d], force_n: [-1, 0, 0], to_s: %g}\n", top,
             organ_load_s);
    const ss_trial_plan plan = {
        .body = body,
        .fixed = fixed,
        .model = "  name: cnn-energy\n  modulus_n_per_m: 60\n  rho: 0.05\n  per_area: false\n"
                 "  mass_kg: 1\n  damping_n_s_per_m: 1\n  rest_stiffness_n_per_m: 0.1\n",
        .rest = loads,
        .step_s = organ_step_s};
    softsim_status status = ss_trial_begin(zhong->paper, &plan, &trial, error);
    if (status != SOFTSIM_OK || trial.world == NULL) {
        ss_paper_miss(zhong->paper, trial.reason, "%s", at->title);
        return status;
    }
    status = ss_trial_run(&trial, (int32_t)(organ_load_s / organ_step_s), error);
    const double depth = -trial.u[top][0], extent = least_extent(body);
    ss_claim_near(zhong->paper, "sec. 5.1.3", SS_FROM_CODE, reference, depth, 1e-3,
                  "%s: depth of the contact at 1 N, m", at->title);
    ss_claim_at_least(zhong->paper, "sec. 5.1.3", SS_FROM_PAPER, 0.1, depth / extent,
                      "%s: goes more than 10 %% of its size (depth over its least extent, "
                      "fraction)",
                      at->title);
    if (status == SOFTSIM_OK) {
        status = draw_organ(zhong, at, body, &trial, top, error);
    }
    if (status == SOFTSIM_OK) {
        status = ss_trial_run(&trial, (int32_t)(organ_left_s / organ_step_s), error);
        ss_claim_near(zhong->paper, "sec. 5.1.3", SS_FROM_CLOSED_FORM,
                      0.5 * (1.0 - sqrt(1.0 - 4.0 * SS_TUBE_KS)),
                      log(depth / largest(&trial)) / organ_left_s, 0.02,
                      "%s: back after unloading: rate of the decay of the largest displacement "
                      "over %g s, 1/s (the slow root of m x'' + gamma x' + ks x)",
                      at->title, organ_left_s);
    }
    ss_trial_end(&trial);
    return status;
}

softsim_status ss_zhong_organs(ss_paper *paper, softsim_error *error)
{
    ss_zhong *zhong = paper->shared;
    softsim_status status = SOFTSIM_OK;
    ss_page_text(&paper->page,
                 "The paper: deformations beyond 10 %% of the body's size, where linear elasticity "
                 "ends. Here: closed bodies held by 6 %% of their points, pushed by 1 N at the "
                 "other end, working set as for the cylinder, then left alone.");
    for (int32_t k = 0; status == SOFTSIM_OK && k < ORGAN_COUNT; ++k) {
        ss_trial_body body = {.node_count = 0};
        char object[256], reason[256];
        snprintf(object, sizeof object,
                 "  mesh: organ.msh\n  units: mm\n  transform: {scale: %.17g}\n", organs[k].scale);
        status = ss_trial_generate(paper, "organ.msh", organs[k].shape, organs[k].points,
                                   organs[k].size_mm, error);
        if (status == SOFTSIM_OK) {
            status = ss_trial_look(paper, object, &body, reason, error);
        }
        if (status == SOFTSIM_OK && body.node_count == 0) {
            ss_paper_miss(paper, reason, "%s", organs[k].title);
        } else if (status == SOFTSIM_OK) {
            status = press_organ(zhong, &organs[k], &body, error);
        }
        ss_trial_body_fini(&body);
        ss_paper_progress(paper, (double)(k + 1) / ORGAN_COUNT);
    }
    return status;
}

/* ---- invariants ---- */

static const bool is_single = sizeof(ss_real) == sizeof(float);
static const int32_t free_points = 322;
static const double free_force[3] = {0.1, 0.2, -0.3};

typedef struct free_run {
    const ss_trial_body *body;
    int32_t node;    /* pushed */
    double force[3]; /* N */
    double damping;  /* N s/m a node */
    double step_s, end_s;
} free_run;

static softsim_status run_free(ss_zhong *zhong, const free_run *run, ss_trial *trial,
                               softsim_error *error)
{
    char model[256], loads[160];
    snprintf(model, sizeof model,
             "  name: cnn-energy\n  modulus_n_per_m: 60\n  rho: 0.05\n  per_area: false\n"
             "  mass_kg: 1\n  damping_n_s_per_m: %g\n  rest_stiffness_n_per_m: 0.1\n",
             run->damping);
    snprintf(loads, sizeof loads, "loads:\n  - {nodes: [%d], force_n: [%.17g, %.17g, %.17g]}\n",
             run->node, run->force[0], run->force[1], run->force[2]);
    const ss_trial_plan plan = {
        .body = run->body, .model = model, .rest = loads, .step_s = run->step_s};
    const softsim_status status = ss_trial_begin(zhong->paper, &plan, trial, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (trial->world == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE, "the free body is refused: %s",
                          trial->reason);
        return SOFTSIM_ERROR_SCENE;
    }
    return ss_trial_run(trial, (int32_t)(run->end_s / run->step_s + 0.5), error);
}

/* x rotated about the world's x, then y, then z, as `rotate_deg` does. */
static void rotate(const double degrees[3], const double x[3], double out[3])
{
    ss_copy3(out, x);
    for (int k = 0; k < 3; ++k) {
        const double a = degrees[k] * SS_PI / 180.0;
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double p = out[i], q = out[j];
        out[i] = cos(a) * p - sin(a) * q;
        out[j] = sin(a) * p + cos(a) * q;
    }
}

/* Largest |a - R b[number]| over the largest |b|. */
static double apart(const ss_trial *a, const ss_trial *b, const double degrees[3],
                    const int32_t *number)
{
    double most = 0.0;
    for (int32_t i = 0; i < a->node_count; ++i) {
        double turned[3], d[3];
        rotate(degrees, b->u[number != NULL ? number[i] : i], turned);
        ss_sub3(d, a->u[i], turned);
        most = fmax(most, ss_norm3(d));
    }
    return most / largest(b);
}

static void claim_same(ss_zhong *zhong, const char *equation, double apart, const char *what)
{
    ss_claim_at_most(zhong->paper, equation, SS_FROM_CLOSED_FORM, is_single ? 1e-5 : 1e-12, apart,
                     "free body%s%s precision)", what, is_single ? "single" : "double");
}

static softsim_status moved_claim(ss_zhong *zhong, const free_run *run, const ss_trial *reference,
                                  softsim_error *error)
{
    static const double degrees[3] = {30.0, 40.0, 50.0};
    ss_trial_body body;
    ss_trial trial;
    char reason[256];
    free_run moved = *run;
    softsim_status status = ss_trial_look(
        zhong->paper,
        "  mesh: free.msh\n  units: mm\n  transform: {rotate_deg: [30, 40, 50], translate_m: "
        "[3, -2, 1]}\n",
        &body, reason, error);
    if (status != SOFTSIM_OK || body.node_count == 0) {
        return status;
    }
    moved.body = &body;
    rotate(degrees, run->force, moved.force);
    status = run_free(zhong, &moved, &trial, error);
    if (status == SOFTSIM_OK) {
        claim_same(zhong, "eq. 26", apart(&trial, reference, degrees, NULL),
                   " of 322 points, turned and moved: the same motion, turned (difference over "
                   "the largest displacement, ");
    }
    ss_trial_end(&trial);
    ss_trial_body_fini(&body);
    return status;
}

static softsim_status renumbered_claim(ss_zhong *zhong, const free_run *run,
                                       const ss_trial *reference, softsim_error *error)
{
    static const double none[3] = {0.0, 0.0, 0.0};
    const ss_trial_body *body = run->body;
    const int32_t n = body->node_count;
    ss_trial_body other = {.node_count = 0};
    ss_trial trial = {.world = NULL};
    char reason[256];
    free_run renumbered = *run;
    int32_t *number = calloc((size_t)n, sizeof *number);
    double(*position)[3] = calloc((size_t)n, sizeof *position);
    int32_t(*triangle)[3] = calloc((size_t)body->triangle_count, sizeof *triangle);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (number != NULL && position != NULL && triangle != NULL) {
        for (int32_t i = 0; i < n; ++i) { /* new i was number[i]; 5 and n = 322 share no factor */
            number[i] = (int32_t)((int64_t)i * 5 % n);
            ss_copy3(position[i], body->rest[number[i]]);
            renumbered.node = number[i] == run->node ? i : renumbered.node;
        }
        for (int32_t t = 0; t < body->triangle_count; ++t) {
            for (int k = 0; k < 3; ++k) {
                int32_t at = 0;
                while (number[at] != body->triangle[body->triangle_count - 1 - t][k]) {
                    ++at;
                }
                triangle[t][k] = at;
            }
        }
        status =
            ss_trial_write_mesh(zhong->paper, "renumbered.msh", n, (const double(*)[3])position,
                                body->triangle_count, (const int32_t(*)[3])triangle, error);
    } else {
        status = ss_memory_fault(error);
    }
    if (status == SOFTSIM_OK) {
        status = ss_trial_look(zhong->paper, "  mesh: renumbered.msh\n  units: m\n", &other, reason,
                               error);
    }
    if (status == SOFTSIM_OK && other.node_count == n) {
        renumbered.body = &other;
        status = run_free(zhong, &renumbered, &trial, error);
        claim_same(zhong, "eq. 27", apart(&trial, reference, none, number),
                   ", points and triangles renumbered: the same motion (");
        ss_trial_end(&trial);
    }
    ss_trial_body_fini(&other);
    SS_EACH(free, number, position, triangle);
    return status;
}

static softsim_status momentum_claim(ss_zhong *zhong, const free_run *run, softsim_error *error)
{
    ss_trial trial;
    free_run undamped = *run;
    undamped.damping = 0.0;
    const softsim_status status = run_free(zhong, &undamped, &trial, error);
    if (status == SOFTSIM_OK) {
        double p[3] = {0.0, 0.0, 0.0};
        for (int32_t i = 0; i < trial.node_count; ++i) {
            ss_add3(p, p, trial.v[i]); /* 1 kg each */
        }
        ss_madd3(p, p, -run->end_s, run->force);
        ss_claim_at_most(zhong->paper, "eq. 26", SS_FROM_CLOSED_FORM, is_single ? 1e-5 : 1e-12,
                         ss_norm3(p) / (run->end_s * ss_norm3(run->force)),
                         "free body without damping: momentum is force times time (error, "
                         "fraction, %s precision)",
                         is_single ? "single" : "double");
    }
    ss_trial_end(&trial);
    return status;
}

/* Energy that the steps make or lose, over the work, at three steps. The pull is outward, so that
 * the strain is never at the kink of max(0, .). */
static softsim_status audit_claim(ss_zhong *zhong, const free_run *run, softsim_error *error)
{
    enum { STEPS = 3 };
    static const double step_s[STEPS] = {0.2, 0.1, 0.05}, pull_n = 0.5;
    double wrong[STEPS];
    char text[192];
    softsim_status status = SOFTSIM_OK;
    for (int k = 0; status == SOFTSIM_OK && k < STEPS; ++k) {
        ss_trial trial;
        softsim_state state;
        free_run audited = *run;
        ss_scale3(audited.force, run->body->rest[run->node],
                  pull_n / ss_norm3(run->body->rest[run->node]));
        audited.step_s = step_s[k];
        status = run_free(zhong, &audited, &trial, error);
        if (status == SOFTSIM_OK) {
            softsim_read(trial.world, &state);
            wrong[k] = fabs(state.elastic_j + state.kinetic_j + state.dissipated_j - state.work_j) /
                       state.work_j;
        }
        ss_trial_end(&trial);
    }
    if (status == SOFTSIM_OK) {
        const double order = 0.5 * log2(wrong[0] / wrong[2]);
        snprintf(text, sizeof text, "%.2g, %.2g, %.2g at steps of %g, %g, %g s: order %.1f",
                 wrong[0], wrong[1], wrong[2], step_s[0], step_s[1], step_s[2], order);
        ss_claim_add(zhong->paper, "eq. 28", SS_FROM_PAPER,
                     order > 3.5 ? SS_CLAIM_PASS : SS_CLAIM_FAIL,
                     "falls with the fourth power of the step or faster", text,
                     "free body: what the steps leave of elastic + kinetic + dissipated - work, "
                     "over the work");
    }
    return status;
}

softsim_status ss_zhong_invariants(ss_paper *paper, softsim_error *error)
{
    ss_zhong *zhong = paper->shared;
    ss_trial_body body = {.node_count = 0};
    ss_trial reference = {.world = NULL};
    char reason[256];
    ss_page_text(&paper->page,
                 "Not in the paper, but implied by it: a free body of 322 points, pushed at one of "
                 "them, moves the same wherever it is and however it is numbered, gains the "
                 "momentum it is given, since forces are equal and opposite in pairs, and its "
                 "energy adds up as well as a fourth-order method can.");
    softsim_status status =
        ss_trial_generate(paper, "free.msh", "ellipsoid", free_points, "2000,1800,1600", error);
    if (status == SOFTSIM_OK) {
        status = ss_trial_look(paper, "  mesh: free.msh\n  units: mm\n", &body, reason, error);
    }
    if (status == SOFTSIM_OK && body.node_count == 0) {
        ss_paper_miss(paper, reason, "invariants of a free body");
    }
    if (status != SOFTSIM_OK || body.node_count == 0) {
        return status;
    }
    free_run run = {.body = &body, .node = 100, .damping = 0.5, .step_s = 0.05, .end_s = 10.0};
    ss_copy3(run.force, free_force);
    status = run_free(zhong, &run, &reference, error);
    if (status == SOFTSIM_OK) {
        status = moved_claim(zhong, &run, &reference, error);
    }
    if (status == SOFTSIM_OK) {
        status = renumbered_claim(zhong, &run, &reference, error);
    }
    ss_trial_end(&reference);
    if (status == SOFTSIM_OK) {
        status = momentum_claim(zhong, &run, error);
    }
    if (status == SOFTSIM_OK) {
        status = audit_claim(zhong, &run, error);
    }
    ss_trial_body_fini(&body);
    return status;
}
