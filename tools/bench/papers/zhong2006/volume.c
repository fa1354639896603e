/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The paper's conclusion: the network in a volume, here a cube of tetrahedra pressed on its top,
 * by the program and by the report's reference network (ss_zhong_net_tetrahedra).
 *
 * In volumes the flux density of an edge is taken through the face that parts its cells, so that
 * the force along an edge is a stress times an area and the modulus is in Pa.
 */
#include <math.h>
#include <stdlib.h>

#include "bench/papers/zhong2006/zhong2006.h"
#include "mesh/mesh.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { CUBE_POINTS = 216, LOADS = 3 };
static const double modulus_pa = 60.0, ks = 0.1, settle_s = 250.0, settle_step_s = 0.05;
static const double load_n[LOADS] = {0.01, 0.1, 1.0};

typedef struct cube {
    ss_mesh *mesh;
    int32_t top, under; /* the middle of its top, and the inner node nearest below */
    double low;         /* height of its bottom, which is fixed */
} cube;

static double distance(const double a[3], const double b[3])
{
    double d[3];
    ss_sub3(d, a, b);
    return ss_norm3(d);
}

static int32_t nearest(const ss_mesh *mesh, const double at[3])
{
    int32_t best = 0;
    for (int32_t i = 1; i < mesh->node_count; ++i) {
        const bool is_nearer = distance(mesh->position[i], at) < distance(mesh->position[best], at);
        best = is_nearer ? i : best;
    }
    return best;
}

static softsim_status make_cube(const ss_paper *paper, cube *out, softsim_error *error)
{
    char path[sizeof paper->temporary + 16];
    static const char *const size = "2000,2000,2000";
    *out = (cube){.mesh = NULL};
    snprintf(path, sizeof path, "%s/cube.msh", paper->temporary);
    softsim_status status =
        ss_trial_generate_solid(paper, "cube.msh", "block", CUBE_POINTS, size, error);
    if (status == SOFTSIM_OK) {
        status = ss_mesh_load(path, 1e-3, NULL, &out->mesh, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    double middle[3] = {0.0, 0.0, 0.0}, high = -(double)INFINITY;
    out->low = (double)INFINITY;
    for (int32_t i = 0; i < out->mesh->node_count; ++i) {
        ss_madd3(middle, middle, 1.0 / out->mesh->node_count, out->mesh->position[i]);
        out->low = fmin(out->low, out->mesh->position[i][2]);
        high = fmax(high, out->mesh->position[i][2]);
    }
    middle[2] = high;
    out->top = nearest(out->mesh, middle);
    middle[2] = high - 0.4 * (high - out->low);
    out->under = nearest(out->mesh, middle);
    return SOFTSIM_OK;
}

/* Fixed nodes and the load, by the numbers of the file, which the program keeps. */
static softsim_status press(ss_zhong *zhong, const cube *c, double force, double out_depth[2],
                            softsim_error *error)
{
    char fixed[128], loads[160];
    ss_trial trial;
    const ss_trial_body body = {.object = "  mesh: cube.msh\n  units: mm\n"};
    snprintf(fixed, sizeof fixed, "[{box_m: [[-9, -9, %.6g], [9, 9, %.6g]]}]", c->low - 0.01,
             c->low + 0.01);
    snprintf(loads, sizeof loads, "loads:\n  - {nodes: [%d], force_n: [0, 0, %.17g]}\n", c->top,
             -force);
    const ss_trial_plan plan = {.body = &body,
                                .fixed = fixed,
                                .model = "  name: cnn-energy\n  domain: volume\n  modulus_pa: 60\n"
                                         "  per_area: false\n  mass_kg: 1\n"
                                         "  damping_n_s_per_m: 1\n  rest_stiffness_n_per_m: 0.1\n",
                                .rest = loads,
                                .step_s = settle_step_s};
    out_depth[0] = out_depth[1] = (double)NAN;
    softsim_status status = ss_trial_begin(zhong->paper, &plan, &trial, error);
    if (status == SOFTSIM_OK && trial.world == NULL) {
        ss_paper_miss(zhong->paper, trial.reason, "the network in a volume");
    } else if (status == SOFTSIM_OK) {
        status = ss_trial_run(&trial, (int32_t)(settle_s / settle_step_s), error);
        /* Where the program has the two nodes. */
        for (int32_t i = 0; i < trial.node_count; ++i) {
            double rest[3];
            ss_sub3(rest, trial.position[i], trial.u[i]);
            const double gap = distance(rest, c->mesh->position[c->top]);
            const double other = distance(rest, c->mesh->position[c->under]);
            out_depth[0] = gap < 1e-4 ? -trial.u[i][2] : out_depth[0];
            out_depth[1] = other < 1e-4 ? -trial.u[i][2] : out_depth[1];
        }
        ss_trial_end(&trial);
    }
    return status;
}

static ss_zhong_net *make_net(const cube *c)
{
    const ss_mesh *mesh = c->mesh;
    ss_zhong_net *net =
        ss_zhong_net_tetrahedra(mesh->node_count, (const double(*)[3])mesh->position,
                                mesh->tetrahedron_count, (const int32_t(*)[4])mesh->tetrahedron);
    if (net == NULL) {
        return NULL;
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        net->is_held[i] = mesh->position[i][2] < c->low + 0.01;
    }
    net->is_source[c->top] = 1;
    if (!ss_zhong_net_solve(net)) {
        ss_zhong_net_destroy(&net);
    }
    return net;
}

/* Does nothing but the loaded node move? */
static bool is_slack(const ss_zhong_net *net, const double (*u)[3], int32_t loaded)
{
    for (int32_t i = 0; i < net->node_count; ++i) {
        if (i != loaded && ss_norm3(u[i]) > 0.0) {
            return false;
        }
    }
    return true;
}

static softsim_status claim_loads(ss_zhong *zhong, const cube *c, ss_zhong_net *net, FILE *csv,
                                  softsim_error *error)
{
    const size_t n = (size_t)net->node_count;
    double(*force)[3] = calloc(n, sizeof *force), (*u)[3] = calloc(n, sizeof *u);
    double *stiffness = calloc(n, sizeof *stiffness);
    softsim_status status =
        force != NULL && u != NULL && stiffness != NULL ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    for (size_t i = 0; status == SOFTSIM_OK && i < n; ++i) {
        stiffness[i] = ks;
    }
    for (int k = 0; status == SOFTSIM_OK && k < LOADS; ++k) {
        double depth[2];
        force[c->top][2] = -load_n[k];
        (void)ss_zhong_net_static(net, modulus_pa, stiffness, (const double(*)[3])force, u);
        status = press(zhong, c, load_n[k], depth, error);
        if (status != SOFTSIM_OK || isnan(depth[0])) {
            break;
        }
        fprintf(csv, "%g,%.8g,%.8g,%.8g,%.8g\n", load_n[k], depth[0], -u[c->top][2], depth[1],
                -u[c->under][2]);
        if (is_slack(net, (const double(*)[3])u, c->top)) {
            ss_claim_near(zhong->paper, "Conclusion", SS_FROM_CLOSED_FORM, load_n[k] / ks, depth[0],
                          1e-3,
                          "a volume of %d tetrahedra, slack: depth of the contact at %g N, force "
                          "over rest stiffness, m",
                          c->mesh->tetrahedron_count, load_n[k]);
            ss_claim_at_most(zhong->paper, "Conclusion", SS_FROM_CLOSED_FORM, 1e-6, fabs(depth[1]),
                             "and a node 0.4 of the height below it stays, m");
        } else {
            ss_claim_near(zhong->paper, "Conclusion", SS_FROM_CODE, -u[c->top][2], depth[0], 1e-3,
                          "a volume of %d tetrahedra: depth of the contact at %g N, m",
                          c->mesh->tetrahedron_count, load_n[k]);
            ss_claim_near(zhong->paper, "Conclusion", SS_FROM_CODE, -u[c->under][2], depth[1], 1e-2,
                          "and of a node 0.4 of the height below it, m (below 0: it rises)");
        }
    }
    SS_EACH(free, force, u, stiffness);
    if (status == SOFTSIM_ERROR_MEMORY) {
        status = ss_memory_fault(error);
    }
    return status;
}

softsim_status ss_zhong_volume(ss_paper *paper, softsim_error *error)
{
    ss_zhong *zhong = paper->shared;
    cube c;
    ss_output csv;
    ss_page_text(
        &paper->page,
        "The paper's future work: the network in a volume, for cutting and tearing. Here: "
        "a cube of 2 m in tetrahedra, its bottom fixed, pressed on the middle of its top; "
        "a cell on every node, inner ones too. Cutting and tearing are not in this "
        "program: no link of the network is ever taken away. A slight dent shortens the links "
        "below it more than it stretches those around it; the network is slack then, and "
        "the contact stands on its rest spring of %g N/m alone.",
        ks);
    softsim_status status = make_cube(paper, &c, error);
    ss_zhong_net *net = status == SOFTSIM_OK ? make_net(&c) : NULL;
    if (status == SOFTSIM_OK && net == NULL) {
        status = ss_memory_fault(error);
    }
    if (status == SOFTSIM_OK) {
        status =
            ss_paper_csv_open(paper, &csv, "volume",
                              "force_n,u_m,reference_u_m,inner_u_m,reference_inner_u_m", error);
    }
    if (status == SOFTSIM_OK) {
        status = claim_loads(zhong, &c, net, csv.file, error);
        status = ss_paper_csv_end(paper, &csv, "volume", status, error);
    }
    ss_zhong_net_destroy(&net);
    ss_mesh_destroy(&c.mesh);
    return status;
}
