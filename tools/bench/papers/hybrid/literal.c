/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The paper's mesh-free equations: the pair curve of its Fig. 2 and what the layer makes of it; the
 * pair forces as printed, over spacings and cut-offs; and the interpolations (7), (11), (13), as
 * printed on a cube of lattice places and as the layer has them on the paper's ellipsoids.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/papers/hybrid/hybrid.h"
#include "models/layer.h"
#include "rt/random.h"
#include "rt/vec.h"

/* W(r) of eq. (8) for epsilon = 1, and F = -dW/dr. */
static double printed_potential(double r)
{
    return 1.0 / (r * r * r) - 1.0 / r;
}

static double printed_force(double r)
{
    return 3.0 / (r * r * r * r) - 1.0 / (r * r);
}

/* The layer's curve against the printed one, W(r) of (8), whose well is at root 3 and 2/(3 root 3)
 * deep: phi(s) must be W(root 3 s) over that depth where the layer does not continue it linearly.
 */
static void claim_pair_curve(ss_paper *paper)
{
    const double depth = 2.0 / (3.0 * sqrt(3.0)), step = 1e-4;
    double apart = 0.0, least = (double)INFINITY, where = 0.0, pull = 0.0, pulled_at = 0.0, slope;
    double before, after;
    for (double s = 0.7; s < 4.0; s += step) {
        const double phi = ss_layer_pair_potential(s, &slope);
        if (s < sqrt(2.0)) {
            apart = fmax(apart, fabs(phi - printed_potential(sqrt(3.0) * s) / depth));
        }
        if (phi < least) {
            least = phi;
            where = s;
        }
        if (slope > pull * (1.0 + 1e-9)) {
            pull = slope;
            pulled_at = s;
        }
    }
    (void)ss_layer_pair_potential(1.0 - step, &before);
    (void)ss_layer_pair_potential(1.0 + step, &after);
    ss_claim_at_most(paper, "Fig. 2", SS_FROM_CLOSED_FORM, 1e-6, apart,
                     "the layer's pair potential is (8) with r in units of root 3 and the well's "
                     "depth as the unit of energy: largest difference from 0.7 to root 2");
    ss_claim_near(paper, "Fig. 2", SS_FROM_PAPER, -1.0, least, 1e-6,
                  "epsilon is the energy that overcomes the cohesion: the well's depth over it "
                  "(with r and epsilon as printed it is -0.385)");
    ss_claim_near(paper, "Fig. 2", SS_FROM_CLOSED_FORM, 1.0, where, 1e-3,
                  "the well lies at the rest distance");
    ss_claim_near(paper, "Fig. 2", SS_FROM_CLOSED_FORM, sqrt(2.0), pulled_at, 1e-3,
                  "cohesion is strongest at root 2 of it");
    ss_claim_near(paper, "Fig. 2", SS_FROM_CLOSED_FORM, 3.0, (after - before) / (2.0 * step), 1e-3,
                  "stiffness at rest, in epsilon over the rest distance squared");
}

softsim_status ss_heart_pair_curve(ss_paper *paper, softsim_error *error)
{
    ss_output csv;
    ss_output script;
    softsim_status status =
        ss_paper_csv_open(paper, &csv, "fig2", "r,printed_W,printed_F,used_phi,used_F", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int k = 0; k <= 400; ++k) {
        const double r = 0.6 + 3.4 * k / 400.0;
        double slope;
        const double phi = ss_layer_pair_potential(r, &slope);
        fprintf(csv.file, "%.6g,%.6g,%.6g,%.6g,%.6g\n", r, printed_potential(r), printed_force(r),
                phi, -slope);
    }
    status = ss_paper_csv_close(paper, &csv, "fig2", error);
    if (status == SOFTSIM_OK) {
        status = ss_plot_open(&script, paper->folder, "fig2", error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    fprintf(script.file,
            "set datafile separator ','\nset xlabel 'r'\nset yrange [-1.5:2]\nset xrange [0.6:4]\n"
            "set xzeroaxis\nplot 'fig2.csv' skip 1 using 1:2 with lines lw 2 title 'W, eq. 8', "
            "'' skip 1 using 1:3 with lines lw 2 dt 2 title 'F = -dW/dr, eq. 8', "
            "'' skip 1 using 1:4 with lines lw 2 title 'phi as used, r in rest distances', "
            "'' skip 1 using 1:5 with lines lw 2 dt 2 title 'its force'\n");
    status = ss_page_plot(&paper->page, &script, "fig2",
                          "Fig. 2: the pair potential as printed, and as the layer uses it: the "
                          "well at each pair's own rest distance, its depth 1, a linear force "
                          "below 0.7 and a constant one beyond root 2.",
                          error);
    if (status == SOFTSIM_OK) {
        claim_pair_curve(paper);
    }
    return status;
}

/* ---- a cube of places ---- */

enum { SIDE = 7, PLACES = SIDE * SIDE * SIDE };

static void place(int32_t p, double out[3])
{
    ss_set3(out, p % SIDE, p / SIDE % SIDE, p / SIDE / SIDE);
}

static double weight(double r)
{
    const double h = 2.05;
    const double s = 1.0 - r * r / (h * h);
    return r < h ? s * s * s : 0.0;
}

/* Largest error, in spacings, of eq. (7) for a translation by one: sum V x W with the kernel
 * normalised for an unbounded lattice. */
static double kernel_error(void)
{
    double unbounded = 0.0;
    double worst = 0.0;
    for (int c = -3 * 49; c <= 3 * 49 + 24; ++c) {
        const int at[3] = {(c + 171) % 7 - 3, (c + 171) / 7 % 7 - 3, (c + 171) / 49 - 3};
        unbounded += weight(sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]));
    }
    for (int32_t p = 0; p < PLACES; ++p) {
        double x[3];
        double sum = 0.0;
        place(p, x);
        for (int32_t q = 0; q < PLACES; ++q) {
            double y[3];
            place(q, y);
            ss_sub3(y, y, x);
            sum += weight(ss_norm3(y)) / unbounded;
        }
        worst = fmax(worst, fabs(sum - 1.0));
    }
    return worst;
}

/* Largest relative error of the uncorrected gradient of eq. (13), sum V u grad W, for u = x. */
static double gradient_error(void)
{
    double worst = 0.0;
    double scale = 0.0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int32_t p = 0; p < PLACES; ++p) {
            double x[3];
            double sum = 0.0;
            place(p, x);
            const int32_t middle = SIDE / 2 * (1 + SIDE + SIDE * SIDE);
            if (pass == 0 && p != middle) {
                continue;
            }
            for (int32_t q = 0; q < PLACES; ++q) {
                double y[3];
                place(q, y);
                ss_sub3(y, y, x);
                const double r = ss_norm3(y);
                const double s = fmax(0.0, 1.0 - r * r / (2.05 * 2.05));
                sum += (y[0] + x[0]) * 6.0 * s * s * y[0] / (2.05 * 2.05);
            }
            scale = pass == 0 ? sum : scale;
            worst = fmax(worst, fabs(sum / scale - 1.0));
        }
    }
    return worst;
}

/* ---- (8) over spacings ---- */

enum { CUBE = 5, CUBE_PLACES = CUBE * CUBE * CUBE, SPACINGS = 9, CUTS = 3, DAMPINGS = 2 };
static const double cut_of[CUTS] = {1.2, 1.6, 2.05}; /* spacings: 6, 18, 32 neighbours */
static const double damping_of[DAMPINGS] = {0.0, 1.0};

/* A cube of particles of unit mass let go under the printed pair forces alone, its places off by a
 * hundredth of the spacing: the largest way of a particle in 10 time units, in spacings. */
static double wander(double spacing, double cut, double damping)
{
    static double x[CUBE_PLACES][3], v[CUBE_PLACES][3], rest[CUBE_PLACES][3];
    const double dt = 0.01, reach = cut * spacing;
    double most = 0.0;
    uint64_t seed = 5;
    memset(v, 0, sizeof v);
    for (int32_t p = 0; p < CUBE_PLACES; ++p) {
        ss_set3(rest[p], spacing * (p % CUBE), spacing * (p / CUBE % CUBE),
                spacing * (p / CUBE / CUBE));
        for (int a = 0; a < 3; ++a) {
            x[p][a] = rest[p][a] + 0.01 * spacing * (ss_random_unit(&seed) - 0.5);
        }
    }
    for (int step = 0; step < 1000 && most < 10.0; ++step) {
        for (int32_t p = 0; p < CUBE_PLACES; ++p) {
            double f[3] = {0};
            for (int32_t q = 0; q < CUBE_PLACES; ++q) {
                double d[3];
                ss_sub3(d, x[p], x[q]);
                const double r = ss_norm3(d);
                if (q != p && r < reach) {
                    ss_madd3(f, f, printed_force(r) / r, d);
                }
            }
            ss_madd3(v[p], v[p], dt, f);
            ss_scale3(v[p], v[p], 1.0 / (1.0 + damping * dt));
        }
        for (int32_t p = 0; p < CUBE_PLACES; ++p) {
            double d[3];
            ss_madd3(x[p], x[p], dt, v[p]);
            ss_sub3(d, x[p], rest[p]);
            most = fmax(most, ss_norm3(d) / spacing);
        }
    }
    return most;
}

/* Where particles keep to their places under (8) as printed. */
static softsim_status search_cohesion(ss_paper *paper, softsim_error *error)
{
    static const char *const head[] = {"spacing",       "cut 1.2",       "cut 1.6",
                                       "cut 2.05",      "1.2, damped 1", "1.6, damped 1",
                                       "2.05, damped 1"};
    ss_output csv;
    double best = (double)INFINITY, best_at[3] = {0.0, 0.0, 0.0};
    const int dampings = paper->is_quick ? 1 : DAMPINGS;
    const softsim_status status =
        ss_paper_csv_open(paper, &csv, "cohesion", "spacing,cut_spacings,damping_per_s,way", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(&paper->page,
                 "Equation 8 as printed, on a cubic lattice of %d particles of unit mass: the "
                 "largest way of a particle in 10 time units, in spacings, by the spacing and by "
                 "how many spacings the force reaches (the paper gives neither). Forces balance "
                 "where the spacing is near root 3, the well of (8), and only next neighbours "
                 "pull.",
                 CUBE_PLACES);
    ss_page_table_begin(&paper->page, 1 + CUTS * dampings, head);
    for (int k = 0; k < SPACINGS; ++k) {
        const double spacing = 1.0 + 0.1 * k;
        ss_row row = {.count = 0};
        ss_row_add(&row, "%.1f", spacing);
        for (int d = 0; d < dampings; ++d) {
            for (int c = 0; c < CUTS; ++c) {
                const double way = wander(spacing, cut_of[c], damping_of[d]);
                fprintf(csv.file, "%g,%g,%g,%.6g\n", spacing, cut_of[c], damping_of[d], way);
                ss_row_add(&row, "%.2f", way);
                if (way < best) {
                    best = way;
                    ss_set3(best_at, spacing, cut_of[c], damping_of[d]);
                }
            }
        }
        ss_page_table_row(&paper->page, row.count, row.cell);
        ss_paper_progress(paper, 0.8 * (k + 1.0) / SPACINGS);
    }
    ss_page_table_end(&paper->page);
    char measured[320];
    snprintf(measured, sizeof measured,
             "%.2f spacings at most at spacing %.1f, forces over %g spacings, damping %g; %.1f at "
             "spacing 1 and %g",
             best, best_at[0], best_at[1], best_at[2], wander(1.0, cut_of[2], 0.0), cut_of[2]);
    ss_claim_add(paper, "eq. 8", SS_FROM_PAPER, best < 0.25 ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
                 "particles cohere: no way above 0.25 spacings", measured,
                 "the printed pair forces hold a lattice together at some spacing and reach");
    ss_claim_search(paper, "spacings 1.0 to 1.8, reaches of 1.2, 1.6 and 2.05 spacings, with and "
                           "without damping, 10 time units");
    return ss_paper_csv_close(paper, &csv, "cohesion", error);
}

/* ---- (7), (11), (13) in the layer ---- */

/* Largest |sum T X - X| of the particles' ties, and of the skin's rows, in spacings. */
static void row_errors(const ss_layer *layer, const ss_mesh *mesh, double *out_tie,
                       double *out_skin)
{
    *out_tie = *out_skin = 0.0;
    for (int32_t p = 0; p < layer->count; ++p) {
        double x[3], whole = 0.0;
        ss_scale3(x, layer->rest[p], -1.0);
        for (int32_t k = layer->tie_first[p]; k < layer->tie_first[p + 1]; ++k) {
            ss_madd3(x, x, (double)layer->tie[k], mesh->position[layer->tie_node[k]]);
            whole += (double)layer->tie[k];
        }
        *out_tie = fmax(*out_tie, fmax(ss_norm3(x) / layer->spacing[p], fabs(whole - 1.0)));
    }
    for (int32_t s = 0; s < layer->skin_count; ++s) {
        double x[3];
        ss_scale3(x, mesh->position[layer->skin_node[s]], -1.0);
        for (int32_t k = layer->skin_first[s]; k < layer->skin_first[s + 1]; ++k) {
            ss_madd3(x, x, (double)layer->skin[k], layer->rest[layer->skin_particle[k]]);
        }
        *out_skin = fmax(*out_skin, ss_norm3(x) / layer->spacing[0]);
    }
}

/* Largest error of the corrected gradient of u = G X over particles, over |G|. */
static double gradient_of_layer(const ss_layer *layer)
{
    static const double g[3][3] = {{0.3, -0.2, 0.5}, {0.1, 0.4, -0.6}, {-0.7, 0.2, 0.1}};
    double most = 0.0, size = 0.0;
    for (int k = 0; k < 9; ++k) {
        size += g[k / 3][k % 3] * g[k / 3][k % 3];
    }
    for (int32_t p = 0; p < layer->own_count; ++p) {
        const ss_real *m = layer->moment + 8 * (ptrdiff_t)p;
        const double inverse[3][3] = {{(double)m[0], (double)m[1], (double)m[2]},
                                      {(double)m[1], (double)m[3], (double)m[4]},
                                      {(double)m[2], (double)m[4], (double)m[5]}};
        double sum[3][3] = {{0.0}}, wrong = 0.0;
        for (int32_t k = layer->pair_first[p]; k < layer->pair_first[p + 1]; ++k) {
            double x[3], u[3];
            ss_sub3(x, layer->rest[layer->neighbour[k]], layer->rest[p]);
            for (int i = 0; i < 3; ++i) {
                u[i] = ss_dot3(g[i], x);
                ss_madd3(sum[i], sum[i], u[i],
                         (const double[3]){(double)layer->pair[4 * k],
                                           (double)layer->pair[4 * k + 1],
                                           (double)layer->pair[4 * k + 2]});
            }
        }
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                const double d = ss_dot3(sum[i], inverse[j]) - g[i][j];
                wrong += d * d;
            }
        }
        most = fmax(most, sqrt(wrong / size));
    }
    return most;
}

static softsim_status claim_rows(ss_paper *paper, softsim_error *error)
{
    ss_layer *layer = NULL;
    double tie, skin;
    ss_mesh *mesh = ss_heart_layered_ellipsoids(paper, error);
    if (mesh == NULL) {
        return error->status;
    }
    const ss_layer_plan plan = {.mesh = mesh, .spacing = 0.06};
    const softsim_status status = ss_layer_create(&plan, &layer, error);
    if (status == SOFTSIM_OK) {
        row_errors(layer, mesh, &tie, &skin);
        ss_claim_at_most(paper, "eq. 7", SS_FROM_CLOSED_FORM, 1e-4, skin,
                         "a linear field is interpolated from %d particles exactly, at every node "
                         "of the surface (error in spacings)",
                         layer->count);
        ss_claim_at_most(paper, "eq. 11", SS_FROM_CLOSED_FORM, 1e-4, tie,
                         "where both interpolations are, shares that add up to 1 give x: largest "
                         "error of a particle's place from the tetrahedra, in spacings");
        ss_claim_at_most(paper, "eq. 13", SS_FROM_CLOSED_FORM, 1e-3, gradient_of_layer(layer),
                         "the gradient of W gives a linear field's own gradient at each of the "
                         "layer's %d particles, at the surface too (error over it)",
                         layer->own_count);
    }
    ss_layer_destroy(&layer);
    ss_mesh_destroy(&mesh);
    return status;
}

/* Eq. (11) where both interpolations are whole, of the identity: its size over that of the place.
 * The corners of a tetrahedron, and a row of this program over particles in and around it. */
static double overlap(void)
{
    static const double at[3] = {0.3, 0.25, 0.2};
    double x[27][3], square[27], row[27], sum[3];
    for (int32_t q = 0; q < 27; ++q) {
        double d[3];
        ss_set3(x[q], 0.5 * (q % 3) - 0.25, 0.5 * (q / 3 % 3) - 0.25, 0.5 * (q / 9) - 0.25);
        ss_sub3(d, x[q], at);
        square[q] = ss_dot3(d, d);
    }
    /* N_1 = x, N_2 = y, N_3 = z of the corners (1, 0, 0), (0, 1, 0), (0, 0, 1); N_0 is at 0. */
    ss_copy3(sum, at);
    if (!ss_layer_fit_row(at, 27, (const double(*)[3])x, square, 8.0, row)) {
        return (double)NAN;
    }
    for (int32_t q = 0; q < 27; ++q) {
        ss_madd3(sum, sum, row[q], x[q]);
    }
    return ss_norm3(sum) / ss_norm3(at);
}

softsim_status ss_heart_literal(ss_paper *paper, softsim_error *error)
{
    const softsim_status status = search_cohesion(paper, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(&paper->page,
                 "Taken without any correction, on a cube of %d lattice places: (7) gives a "
                 "translation by 1 wrong by up to %.2f at corners, since the kernel is not "
                 "normalised where the body ends; (11) adds two whole interpolations and gives "
                 "%.3g x; the gradient in (13) of u = x is wrong by up to %.1f times itself near "
                 "the surface. The paper writes (7) and (11) with an approximate sign and leaves "
                 "open how its functions are normalised; normalised ones, as this program has "
                 "them, are exact for linear fields:",
                 PLACES, kernel_error(), overlap(), gradient_error());
    return claim_rows(paper, error);
}
