/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Equations 14 to 18 and 26: the program's static shapes against those of the report's reference
 * network, whose conductances are taken from the printed equations cell by cell; and one hexagon,
 * of which the closure can be solved by hand.
 *
 * Hexagon: a cell and six fixed ones at distance h. (17) gives w = 1/sqrt 3, S = sqrt 3 h^2/2,
 * ghat = h^2/(4 rho), q = 1/4, Qhat = 3 h^2/2; hence at rest ks z + 3 E z^3/(4 h^2) = F, and with
 * the output at its bound K, z = F/(ks + 6 rho K/h^2).
 */
#include <math.h>
#include <string.h>

#include "bench/papers/zhong2006/zhong2006.h"
#include "rt/vec.h"

/* ---- the cylinder ---- */

typedef struct template_case {
    const char *figure[2], *what; /* of the grid, of triangles */
    double across;                /* 0: isotropic */
    bool has_bands;
} template_case;

static const template_case cases[] = {
    {{"eq. 14", "eq. 17"}, "isotropic", 0.0, false},
    {{"eq. 15", "eq. 17"}, "anisotropic, twice as much around the axis", 2.0, false},
    {{"eq. 16", "eq. 18"}, "inhomogeneous, ring by ring 0.05 and 0.1", 0.0, true},
};
enum { CASE_COUNT = sizeof cases / sizeof cases[0] };

static softsim_status compare(ss_zhong *zhong, const ss_tube *tube, const template_case *at,
                              FILE *csv, softsim_error *error)
{
    double rho[SS_TUBE_POINTS], depth, width, reference_width = 0.0;
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        rho[i] = at->has_bands && i / SS_TUBE_COLUMNS % 2 == 0 ? 0.1 : SS_TUBE_RHO;
    }
    const ss_tube_setup setup = {.rho = at->has_bands ? rho : NULL,
                                 .across = at->across,
                                 .rho_along = SS_TUBE_RHO,
                                 .load = {{.point = SS_TUBE_CONTACT, .force = 1.0}},
                                 .load_count = 1};
    softsim_status status =
        ss_tube_static(zhong->paper, tube, &setup, at->what, &depth, &width, NULL, error);
    ss_zhong_net *net = status == SOFTSIM_OK ? ss_tube_net(tube, rho, at->across) : NULL;
    if (net == NULL || isnan(depth)) {
        ss_zhong_net_destroy(&net);
        return status;
    }
    const double reference = ss_tube_net_static(net, 1.0, NULL, &reference_width);
    ss_zhong_net_destroy(&net);
    fprintf(csv, "%s,\"%s\",%.9g,%.9g,%.9g,%.9g\n", tube->name, at->what, depth, reference, width,
            reference_width);
    const char *figure = at->figure[tube->is_grid ? 0 : 1];
    ss_claim_near(zhong->paper, figure, SS_FROM_CODE, reference, depth, SS_CODE_TOLERANCE,
                  "%s, %s: depth at 1 N as from the printed conductances, m", tube->name, at->what);
    ss_claim_near(zhong->paper, figure, SS_FROM_CODE, reference_width, width, SS_CODE_TOLERANCE,
                  "%s, %s: ring width, m", tube->name, at->what);
    return status;
}

/* Uniform rho cancels; two grids of one body agree. */
static softsim_status compare_more(ss_zhong *zhong, softsim_error *error)
{
    static double rho[SS_TUBE_POINTS];
    double reference[2] = {(double)NAN, (double)NAN}, depth = (double)NAN, width;
    softsim_status status = SOFTSIM_OK;
    const ss_tube_setup setup = {
        .rho = rho, .load = {{.point = SS_TUBE_CONTACT, .force = 0.25}}, .load_count = 1};
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        rho[i] = 1000.0 * SS_TUBE_RHO;
    }
    for (int k = 0; status == SOFTSIM_OK && k < 2; ++k) {
        const ss_tube *tube = &zhong->tube[k];
        ss_zhong_net *net = tube->is_there ? ss_tube_net(tube, NULL, 0.0) : NULL;
        if (net == NULL) {
            continue;
        }
        reference[k] = ss_tube_net_static(net, 0.25, NULL, NULL);
        ss_zhong_net_destroy(&net);
        status = ss_tube_static(zhong->paper, tube, &setup, "rho 50", &depth, &width, NULL, error);
        ss_claim_near(zhong->paper, "eq. 26", SS_FROM_CODE, reference[k], depth, SS_CODE_TOLERANCE,
                      "%s: a thousandfold rho everywhere changes nothing while no cell saturates: "
                      "depth at 0.25 N, m (expected: with rho 0.05)",
                      tube->name);
    }
    if (status == SOFTSIM_OK && !isnan(reference[0]) && !isnan(reference[1])) {
        ss_claim_near(zhong->paper, "eq. 17", SS_FROM_CODE, reference[0], depth, 0.02,
                      "triangles against the grid of (14): depth at 0.25 N, m");
    }
    return status;
}

/* ---- the hexagon ---- */

static const double edge_m = 0.3, modulus = 7.0, ks = 0.3;

static double hexagon_depth(double force)
{
    double z = 0.0;
    for (int k = 0; k < 100; ++k) { /* Newton from above: the function is convex for z > 0 */
        const double cubic = 0.75 * modulus / (edge_m * edge_m);
        z = k == 0 ? force / ks
                   : z - (ks * z + cubic * z * z * z - force) / (ks + 3.0 * cubic * z * z);
    }
    return z;
}

static softsim_status run_hexagon(ss_zhong *zhong, const ss_trial_body *body, double force,
                                  double saturation, double *out_depth, softsim_error *error)
{
    char model[320], loads[128];
    ss_trial trial;
    int used = snprintf(model, sizeof model,
                        "  name: cnn-energy\n  modulus_n_per_m: %g\n  rho: %g\n  per_area: false\n"
                        "  mass_kg: 1\n  damping_n_s_per_m: 1\n  rest_stiffness_n_per_m: %g\n",
                        modulus, SS_TUBE_RHO, ks);
    if (saturation > 0.0) {
        snprintf(model + used, sizeof model - (size_t)used, "  saturation: %g\n", saturation);
    }
    snprintf(loads, sizeof loads, "loads:\n  - {nodes: [0], force_n: [0, 0, %g]}\n", force);
    const ss_trial_plan plan = {.body = body,
                                .fixed = "[{nodes: [1, 2, 3, 4, 5, 6]}]",
                                .model = model,
                                .rest = loads,
                                .step_s = 0.05};
    softsim_status status = ss_trial_begin(zhong->paper, &plan, &trial, error);
    *out_depth = (double)NAN;
    if (status == SOFTSIM_OK && trial.world == NULL) {
        ss_paper_miss(zhong->paper, trial.reason, "the hexagon%s",
                      saturation > 0.0 ? ", saturated" : "");
    } else if (status == SOFTSIM_OK) {
        status = ss_trial_run(&trial, 6000, error);
        *out_depth = trial.u[0][2];
        ss_trial_end(&trial);
    }
    return status;
}

static softsim_status hexagon_claims(ss_zhong *zhong, softsim_error *error)
{
    static const double force[2] = {0.05, 0.5}, saturation = 0.2;
    double position[7][3] = {{0.0, 0.0, 0.0}}, depth, free_depth[2] = {0.0, 0.0};
    int32_t triangle[6][3];
    ss_trial_body body;
    char reason[256];
    for (int k = 0; k < 6; ++k) {
        const double angle = k * SS_PI / 3.0;
        ss_set3(position[1 + k], edge_m * cos(angle), edge_m * sin(angle), 0.0);
        const int32_t corner[3] = {0, 1 + k, 1 + (k + 1) % 6};
        memcpy(triangle[k], corner, sizeof corner);
    }
    softsim_status status =
        ss_trial_write_mesh(zhong->paper, "hexagon.msh", 7, (const double(*)[3])position, 6,
                            (const int32_t(*)[3])triangle, error);
    if (status == SOFTSIM_OK) {
        status =
            ss_trial_look(zhong->paper, "  mesh: hexagon.msh\n  units: m\n", &body, reason, error);
    }
    if (status != SOFTSIM_OK || body.node_count == 0) {
        return status;
    }
    for (int k = 0; status == SOFTSIM_OK && k < 2; ++k) {
        status = run_hexagon(zhong, &body, force[k], 0.0, &depth, error);
        if (!isnan(depth)) {
            ss_claim_near(zhong->paper, "eq. 27", SS_FROM_CLOSED_FORM, hexagon_depth(force[k]),
                          depth, 1e-5, "hexagon: static depth at %g N as solved by hand, m",
                          force[k]);
        }
        free_depth[k] = depth;
    }
    if (status == SOFTSIM_OK && !isnan(free_depth[0]) && !isnan(free_depth[1])) {
        const double net[2] = {force[0] - ks * free_depth[0], force[1] - ks * free_depth[1]};
        ss_claim_near(zhong->paper, "eq. 27", SS_FROM_CLOSED_FORM, 3.0,
                      log(net[1] / net[0]) / log(free_depth[1] / free_depth[0]), 1e-3,
                      "hexagon: where the nonlinearity comes from: the network's force grows as "
                      "this power of the displacement, since Green strain is quadratic");
    }
    if (status == SOFTSIM_OK) {
        status = run_hexagon(zhong, &body, force[1], saturation, &depth, error);
    }
    if (status == SOFTSIM_OK && !isnan(depth)) {
        ss_claim_near(zhong->paper, "eq. 1", SS_FROM_CLOSED_FORM,
                      force[1] / (ks + 6.0 * SS_TUBE_RHO * saturation / (edge_m * edge_m)), depth,
                      1e-5,
                      "hexagon: the output bounded by K 0.2 softens it: depth at 0.5 N by hand, m");
    }
    ss_trial_body_fini(&body);
    return status;
}

softsim_status ss_zhong_templates(ss_paper *paper, softsim_error *error)
{
    ss_zhong *zhong = paper->shared;
    ss_output csv;
    ss_page_text(
        &paper->page,
        "The paper: Poisson's equation on rectangular grids (14), for anisotropic (15) and "
        "inhomogeneous (16) material, and on triangles (17), (18); a cell's templates are "
        "its coefficients (20), and the flux between two cells is the force between two "
        "points (26), (27). Here: the same static problems solved by a second "
        "implementation straight from the printed coefficients, in double precision with "
        "dense algebra, and one hexagon of cells solved by hand. On triangles the paper "
        "has no anisotropic form: an edge at the angle t to the axis takes rho along times "
        "cos^2 t plus rho across times sin^2 t.");
    softsim_status status =
        ss_paper_csv_open(paper, &csv, "templates",
                          "mesh,case,depth_m,reference_depth_m,width_m,reference_width_m", error);
    for (int k = 0; status == SOFTSIM_OK && k < 2; ++k) {
        for (int32_t c = 0; zhong->tube[k].is_there && status == SOFTSIM_OK && c < CASE_COUNT;
             ++c) {
            status = compare(zhong, &zhong->tube[k], &cases[c], csv.file, error);
            ss_paper_progress(paper, 0.4 * k + 0.1 * c);
        }
    }
    status = ss_paper_csv_end(paper, &csv, "templates", status, error);
    if (status == SOFTSIM_OK) {
        status = compare_more(zhong, error);
    }
    return status == SOFTSIM_OK ? hexagon_claims(zhong, error) : status;
}
