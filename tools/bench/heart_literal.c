/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The paper's mesh-free equations taken at their word, on a cube of lattice places; and the pair
 * curve of its Fig. 2.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "heart.h"
#include "models/layer_kernels.h"
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

softsim_status ss_heart_pair_curve(ss_paper *paper, softsim_error *error)
{
    ss_output csv;
    ss_output script;
    double least = (double)INFINITY;
    double where = 0.0;
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
        if (printed_potential(r) < least) {
            least = printed_potential(r);
            where = r;
        }
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
    ss_claim_at_most(paper, "Fig. 2", 1e-12, fabs(printed_potential(1.0)),
                     "the printed potential is 0 at r = 1");
    ss_claim_near(paper, "Fig. 2", sqrt(3.0), where, 0.01, "its least value lies at root 3");
    ss_claim_near(paper, "Fig. 2", -0.3849, least, 0.001,
                  "that value, not -1: epsilon is not the energy of the well");
    return status;
}

/* ---- a cube of places ----------------------------------------------------------------------- */

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

/* The cube let go under the printed pair forces alone, in unit masses, spacings as r: how far its
 * size has grown, and whether it still grows, after some time units. */
static double burst(void)
{
    static double x[PLACES][3];
    static double v[PLACES][3];
    memset(v, 0, sizeof v);
    for (int32_t p = 0; p < PLACES; ++p) {
        place(p, x[p]);
    }
    const double dt = 0.005;
    for (int step = 0; step < 300; ++step) {
        for (int32_t p = 0; p < PLACES; ++p) {
            double f[3] = {0};
            for (int32_t q = 0; q < PLACES; ++q) {
                double d[3];
                ss_sub3(d, x[p], x[q]);
                const double r = ss_norm3(d);
                if (q != p && r < 2.05) {
                    ss_madd3(f, f, printed_force(r) / r, d);
                }
            }
            ss_madd3(v[p], v[p], dt, f);
        }
        for (int32_t p = 0; p < PLACES; ++p) {
            ss_madd3(x[p], x[p], dt, v[p]);
        }
    }
    double low = (double)INFINITY;
    double high = -(double)INFINITY;
    for (int32_t p = 0; p < PLACES; ++p) {
        low = fmin(low, x[p][0]);
        high = fmax(high, x[p][0]);
    }
    return (high - low) / (SIDE - 1);
}

/* Eq. (11) where both interpolations are whole, of the identity: its size over that of the place.
 * The corners of a tetrahedron, and a row of this program over particles in and around it. */
static double overlap(void)
{
    static const double at[3] = {0.3, 0.25, 0.2};
    double x[27][3];
    double square[27];
    double row[27];
    double sum[3];
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
    char measured[200];
    (void)error;
    ss_page_text(&paper->page,
                 "On a cube of %d lattice places, without this program's corrections. What the "
                 "program does instead: rows of moving least squares, exact for affine maps (7); a "
                 "rest distance for each pair (8); shares that add up to one (11); forces that are "
                 "the slope of an energy (13).",
                 PLACES);
    const double kernel = kernel_error();
    snprintf(measured, sizeof measured,
             "a translation by 1 comes out wrong by up to %.2f at corners: the kernel is not "
             "normalised where the body ends",
             kernel);
    ss_claim_add(paper, "eq. 7", kernel > 0.1 ? SS_CLAIM_DIFFERS : SS_CLAIM_FAIL,
                 "the integral reproduces x(u)", measured, "interpolation by a kernel");
    const double size = burst();
    snprintf(measured, sizeof measured,
             "the cube is %.1f times its size after 1.5 time units: the forces are not 0 at any "
             "lattice's distances",
             size);
    ss_claim_add(paper, "eq. 8", size > 1.3 ? SS_CLAIM_DIFFERS : SS_CLAIM_FAIL,
                 "particles cohere at their distances", measured,
                 "the pair potential between neighbours at rest");
    const double twice = overlap();
    snprintf(measured, sizeof measured,
             "%.3g x: both interpolations are whole where both are; shares must sum to 1", twice);
    ss_claim_add(paper, "eq. 11", fabs(twice - 1.0) > 0.1 ? SS_CLAIM_DIFFERS : SS_CLAIM_FAIL,
                 "x in the overlap", measured,
                 "the mixed interpolation where both functions are not zero");
    const double gradient = gradient_error();
    snprintf(measured, sizeof measured,
             "the gradient of u = x is wrong by up to %.1f times itself near the surface",
             gradient);
    ss_claim_add(paper, "eq. 13", gradient > 0.1 ? SS_CLAIM_DIFFERS : SS_CLAIM_FAIL,
                 "stress forces from a gradient of W", measured,
                 "the uncorrected gradient of a linear field");
    return SOFTSIM_OK;
}
