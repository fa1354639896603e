/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Equations 5 to 9 as printed: I = sigma:eps at the contact, linear strain (6), Hooke's law (7).
 * Where they are well-posed, with rest springs ks, on the cylinder of triangles.
 *
 * For a given current the shape is linear, u(I) = (I L_q + ks)^-1 (F - I L_q P0), and an
 * equilibrium is a root of I = D(u(I)), D the density. With i = I/ks, f = F/ks, c = C/ks and u = f
 * b(i) + p(i) that is i = c D1(f b + p), D1 the density for a unit tensor: all of F, ks and C lie
 * on a map of two numbers, c and f. Without a load a dent is an equilibrium where c D1(p(i)) = i
 * for some i > 0, hence where c >= c* = min i/D1(p(i)), whatever the force was; below c* rest is
 * the only one.
 *
 * Loops: a hexagon's centre held at u is pushed back by 3/2 I(u) u, I = a r^2 + b z^2 with r along
 * the plane and z out of it. Its curl is 3 (a - b) r z: a hand that leads it round a rectangle X by
 * Z, along the plane first, pays 3/4 (a - b) X^2 Z^2, and the other way round it gets as much.
 * a = (lambda + 3 mu)/2 g^2, b = mu g^2, g^2 = 4/(3 h^2), so a - b = (lambda + mu)/2 g^2, which is
 * 0 only at lambda = -mu, a negative bulk modulus.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/papers/zhong2006/zhong2006.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { CURRENTS = 96, TENSORS = 81, LOADS = 61 };
static const double least_i = 1e-4, most_i = 1e4;                              /* of I/ks */
static const double least_c = 0.1, most_c = 1e4, least_f = 1e-2, most_f = 1e2; /* 1/m, m */

/* D1(f b + p) = f^2 bb + f bp + pp at each i, and the contact's depth f b + p. */
typedef struct table {
    double i[CURRENTS], bb[CURRENTS], bp[CURRENTS], pp[CURRENTS], depth_b[CURRENTS],
        depth_p[CURRENTS];
} table;

static double spaced(int k, int count, double least, double most)
{
    return least * pow(most / least, (double)k / (count - 1));
}

static bool fill(const ss_zhong_net *net, const ss_tube *tube, double across, table *out)
{
    static double none[SS_TUBE_POINTS][3], unit[SS_TUBE_POINTS][3], p[SS_TUBE_POINTS][3],
        b[SS_TUBE_POINTS][3];
    double ks[SS_TUBE_POINTS];
    ss_zhong_motion motion;
    ss_zhong_law law = {.source = SS_ZHONG_DENSITY};
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        ks[i] = 1.0;
    }
    unit[SS_TUBE_CONTACT][1] = -1.0;
    bool is_good = ss_zhong_hooke(1.0, across, law.tensor) &&
                   ss_zhong_motion_init(&motion, net, &law, SS_TUBE_CONTACT, SS_TUBE_TRIANGLES,
                                        (const int32_t(*)[3])tube->triangle);
    for (int k = 0; is_good && k < CURRENTS; ++k) {
        double density[3];
        out->i[k] = spaced(k, CURRENTS, least_i, most_i);
        is_good = ss_zhong_net_shape(net, out->i[k], ks, (const double(*)[3])none, p) &&
                  ss_zhong_net_shape(net, out->i[k], ks, (const double(*)[3])unit, b);
        for (int32_t n = 0; n < SS_TUBE_POINTS; ++n) {
            ss_sub3(b[n], b[n], p[n]); /* what the force alone does */
        }
        for (int part = 0; part < 3; ++part) { /* b, p, both */
            for (int32_t n = 0; n < SS_TUBE_POINTS; ++n) {
                ss_scale3(motion.u[n], part != 1 ? b[n] : p[n], 1.0);
                ss_madd3(motion.u[n], motion.u[n], part == 2 ? 1.0 : 0.0, p[n]);
            }
            density[part] = ss_zhong_motion_current(&motion);
        }
        out->bb[k] = density[0];
        out->pp[k] = density[1];
        out->bp[k] = density[2] - density[0] - density[1];
        out->depth_b[k] = -b[SS_TUBE_CONTACT][1];
        out->depth_p[k] = -p[SS_TUBE_CONTACT][1];
    }
    ss_zhong_motion_fini(&motion);
    return is_good;
}

static double critical(const table *t)
{
    double least = (double)INFINITY;
    for (int k = 0; k < CURRENTS; ++k) {
        least = fmin(least, t->i[k] / t->pp[k]);
    }
    return least;
}

/* Roots of i = c D1 beyond i = 0; out_depth (may be NULL): of the first, over one of f. */
static int count_shapes(const table *t, double c, double f, double *out_depth)
{
    int count = 0;
    double before = f > 0.0 ? 1.0 : -1.0; /* of c D1 - i near i = 0 */
    for (int k = 0; k < CURRENTS; ++k) {
        const double now = c * (f * f * t->bb[k] + f * t->bp[k] + t->pp[k]) - t->i[k];
        if (now * before < 0.0) {
            if (count++ == 0 && out_depth != NULL) {
                *out_depth = f * t->depth_b[k] + t->depth_p[k];
            }
            before = now;
        }
    }
    return count;
}

/* ---- runs ---- */

static const struct run {
    double force, ks, c; /* N, N/m, Pa */
} density_runs[] = {{0.5, 0.1, 0.06}, {0.5, 0.1, 0.6},  {0.5, 0.1, 2.0},  {0.5, 0.3, 6.0},
                    {0.1, 0.1, 2.0},  {2.0, 0.1, 0.6},  {2.0, 0.1, 2.0},  {0.5, 0.1, 6.0},
                    {0.1, 0.1, 6.0},  {0.5, 0.3, 60.0}, {0.5, 0.1, 60.0}, {0.5, 0.1, 600.0}};
enum { RUN_COUNT = sizeof density_runs / sizeof density_runs[0] };

/* Runs every point of the list; the worst that is left where the map says that rest is the only
 * shape, and the least where it does not. */
static softsim_status run_all(ss_paper *paper, const ss_zhong_net *net, const ss_tube *tube,
                              double across, double limit, FILE *csv, FILE *points,
                              double *out_left, softsim_error *error)
{
    static const char *const head[] = {
        "C, Pa", "ks, N/m", "F, N", "C/ks, 1/m", "depth, m", "left after 200 s, %", "map"};
    softsim_status status = SOFTSIM_OK;
    const int stride = paper->is_quick ? 3 : 1;
    *out_left = 0.0;
    ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
    for (int k = 0; status == SOFTSIM_OK && k < RUN_COUNT; k += stride) {
        const struct run *at = &density_runs[k];
        ss_zhong_law law = {
            .source = SS_ZHONG_DENSITY, .mass = 1.0, .damping = 2.0, .rest_stiffness = at->ks};
        char name[64];
        ss_zhong_outcome out;
        ss_row row = {.count = 0};
        snprintf(name, sizeof name, "C %g across %g ks %g", at->c, across * at->c, at->ks);
        if (!ss_zhong_hooke(at->c, across * at->c, law.tensor)) {
            softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "no tensor for C %g", at->c);
            status = SOFTSIM_ERROR_MEMORY;
            break;
        }
        status = ss_zhong_load_and_leave(net, tube, &law, name, at->force, 200.0, csv, &out, error);
        const double ratio = at->c / at->ks;
        if (ratio < limit) {
            *out_left = fmax(*out_left, out.left);
        }
        fprintf(points, "%g,%g,%g,%g,%g,%.6g,%.6g\n", across, at->c, at->ks, at->force, ratio,
                out.loaded, out.left);
        ss_row_add_number(&row, at->c);
        ss_row_add_number(&row, at->ks);
        ss_row_add_number(&row, at->force);
        ss_row_add_number(&row, ratio);
        ss_row_add_number(&row, out.loaded);
        ss_row_add(&row, "%.2f", 100.0 * out.left);
        ss_row_add(&row, "%s", ratio < limit ? "rest alone" : "dents too");
        ss_page_table_row(&paper->page, row.count, row.cell);
        ss_paper_progress(paper, 0.2 + (across == 1.0 ? 0.0 : 0.4) + 0.4 * (k + 1.0) / RUN_COUNT);
    }
    ss_page_table_end(&paper->page);
    return status;
}

/* ---- loops ---- */

/* Work of a hand that leads a hexagon's centre round a rectangle from 0 along the plane to x, out
 * to z, back and in; and of its way out. */
static bool lead_round(double along, double across, double x, double z, double out_work[2])
{
    static const double edge_m = 0.3;
    enum { STEPS = 400 };
    int32_t triangle[6][3];
    ss_zhong_law law = {.source = SS_ZHONG_DENSITY};
    ss_zhong_motion motion = {.net = NULL};
    ss_zhong_net *net = ss_zhong_net_hexagon(edge_m, triangle);
    bool is_good = net != NULL && ss_zhong_hooke(along, across, law.tensor);
    is_good = is_good && ss_zhong_net_solve(net) &&
              ss_zhong_motion_init(&motion, net, &law, 0, 6, (const int32_t(*)[3])triangle);
    ss_set3(motion.axis, 1.0, 0.0, 0.0);
    out_work[0] = out_work[1] = 0.0;
    for (int k = 0; is_good && k < 4 * STEPS; ++k) {
        const int side = k / STEPS;
        const double share = (k % STEPS + 0.5) / STEPS;
        double pull[7][3], at[7][3];
        motion.u[0][0] = side == 0   ? share * x
                         : side == 1 ? x
                         : side == 2 ? (1.0 - share) * x
                                     : 0.0;
        motion.u[0][2] = side == 0   ? 0.0
                         : side == 1 ? share * z
                         : side == 2 ? z
                                     : (1.0 - share) * z;
        for (int32_t i = 0; i < 7; ++i) {
            ss_add3(at[i], net->rest[i], motion.u[i]);
        }
        ss_zhong_net_pull(net, (const double(*)[3])at, pull);
        const double step = (side == 0 ? x : side == 1 ? z : side == 2 ? -x : -z) / STEPS;
        const double work =
            ss_zhong_motion_current(&motion) * pull[0][side % 2 == 0 ? 0 : 2] * step;
        out_work[0] += work;
        out_work[1] += side < 2 ? work : 0.0;
    }
    ss_zhong_motion_fini(&motion);
    ss_zhong_net_destroy(&net);
    return is_good;
}

static void claim_loops(ss_paper *paper)
{
    static const double x = 0.1, z = 0.1, edge_m = 0.3, young = 60.0, nu = 0.3;
    const double mu = 0.5 * young / (1.0 + nu), lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
    const double by_hand = 0.5 * (lambda + mu) * x * x * z * z / (edge_m * edge_m);
    double isotropic[2], other[2];
    char text[320];
    if (!lead_round(young, young, x, z, isotropic) ||
        !lead_round(young, 2.0 * young, x, z, other)) {
        return;
    }
    ss_claim_near(
        paper, "eq. 9", SS_FROM_CLOSED_FORM, by_hand, isotropic[0], 1e-4,
        "hexagon, isotropic C of 60 Pa: work of a hand round a rectangle of %g by %g m, J "
        "(reference network)",
        x, z);
    snprintf(text, sizeof text,
             "one way round the hand gets %.3g J, the other way it pays them; its way in takes "
             "%.3g J; C of 60 and 120 Pa: %.3g J of %.3g J",
             isotropic[0], isotropic[1], other[0], other[1]);
    ss_claim_add(paper, "eq. 9", SS_FROM_PAPER,
                 fabs(isotropic[0]) <= 1e-6 * isotropic[1] ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
                 "no work in a closed path", text,
                 "section 2: the change in potential energy is the work of the external force: no "
                 "energy from a closed path under I = sigma:eps (reference network)");
    ss_claim_search(paper,
                    "every isotropic C by hand: the work is (lambda + mu) X^2 Z^2/(2 h^2), 0 "
                    "only at lambda = -mu, a negative bulk modulus; rest springs and "
                    "damping change nothing of it; an orthotropic C was measured");
}

/* ---- the section ---- */

static softsim_status write_map(ss_paper *paper, const table *t, double *out_one,
                                softsim_error *error)
{
    ss_output csv;
    const double limit = critical(t);
    const softsim_status status = ss_paper_csv_open(
        paper, &csv, "density-map",
        "c_over_ks_per_m,f_over_ks_m,shapes_loaded,dents_unloaded,depth_m", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    *out_one = 0.0;
    for (int a = 0; a < TENSORS; ++a) {
        const double c = spaced(a, TENSORS, least_c, most_c);
        bool is_one = c < limit;
        for (int b = 0; b < LOADS; ++b) {
            const double f = spaced(b, LOADS, least_f, most_f);
            double depth = (double)NAN;
            const int loaded = count_shapes(t, c, f, &depth);
            is_one = is_one && loaded == 1;
            fprintf(csv.file, "%.6g,%.6g,%d,%d,%.5g\n", c, f, loaded, count_shapes(t, c, 0.0, NULL),
                    depth);
        }
        fputc('\n', csv.file); /* a column of the picture */
        *out_one = is_one ? c : *out_one;
    }
    return ss_paper_csv_close(paper, &csv, "density-map", error);
}

static softsim_status plot_map(ss_paper *paper, double limit, softsim_error *error)
{
    ss_output script;
    const softsim_status status =
        ss_plot_open_sized(&script, paper->folder, "density-map", 800, 520, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_plot_key_below(script.file, 5);
    fprintf(script.file,
            "set datafile separator ','\nset logscale xy\nset xrange [%g:%g]\nset yrange [%g:%g]\n"
            "set xlabel 'C/ks, 1/m'\nset ylabel 'F/ks, m'\nset format '10^{%%T}'\n"
            "set style fill solid 1.0 noborder\n"
            "plot 'density-map.csv' skip 1 using 1:($3==1 && $4==0 ? $2 : NaN) with points pt 5 ps "
            "0.75 lc rgb '#cfe8cf' title 'one shape a load, rest alone without', "
            "'' skip 1 using 1:($3!=1 && $4==0 ? $2 : NaN) with points pt 5 ps 0.75 lc rgb "
            "'#f5e3b3' title 'several under load, rest alone without', "
            "'' skip 1 using 1:($4!=0 ? $2 : NaN) with points pt 5 ps 0.75 lc rgb '#f2c9c5' title "
            "'dents without a load too', "
            "'density-runs.csv' skip 1 using 5:($1==1 && $7<=0.01 ? $4/$3 : NaN) with points pt 7 "
            "lc rgb '#107010' title 'run, back', "
            "'' skip 1 using 5:($1==1 && $7>0.01 ? $4/$3 : NaN) with points pt 2 lw 2 lc rgb "
            "'#b02020' title 'run, dent left'\n",
            least_c, most_c, least_f, most_f);
    char caption[240];
    snprintf(caption, sizeof caption,
             "Equations 5 to 9 with rest springs, isotropic C: rest is the only shape without a "
             "load below C/ks = %.3g 1/m.",
             limit);
    return ss_page_plot(&paper->page, &script, "density-map", caption, error);
}

static void claim_map(ss_paper *paper, double limit, double one, const double left[2],
                      double other_limit)
{
    char text[320];
    snprintf(text, sizeof text,
             "%.2g %% left at most of the runs below %.3g 1/m; C of 1 to 2, orthotropic: %.2g %% "
             "below %.3g",
             100.0 * left[0], limit, 100.0 * left[1], other_limit);
    ss_claim_add(paper, "eq. 9", SS_FROM_PAPER,
                 left[0] <= 0.01 && left[1] <= 0.01 ? SS_CLAIM_PASS : SS_CLAIM_FAIL,
                 "back after unloading", text,
                 "I = sigma:eps with rest springs, C/ks below what the map allows: elastic, "
                 "returns to its natural state (reference network)");
    snprintf(text, sizeof text, "one shape for each load up to C/ks %.3g 1/m", one);
    ss_claim_add(
        paper, "eq. 9", SS_FROM_PAPER, one > 0.0 ? SS_CLAIM_PASS : SS_CLAIM_DIFFERS,
        "some C and ks", text,
        "I = sigma:eps with rest springs: one shape for each load and one without (reference "
        "network)");
    ss_claim_search(paper, "C/ks from %g to %g 1/m, F/ks from %g to %g m", least_c, most_c, least_f,
                    most_f);
}

softsim_status ss_zhong_density(ss_paper *paper, softsim_error *error)
{
    static table isotropic, orthotropic;
    ss_zhong *zhong = paper->shared;
    const ss_tube *tube = &zhong->tube[1];
    ss_output csv, points;
    double left[2], one = 0.0;
    ss_page_text(&paper->page,
                 "The paper: for a point contact the current is the strain energy density (5) with "
                 "the linear strain (6) and Hooke's law (7) to (9), isotropic or not. Without a "
                 "load the dent's own strain keeps a current up, which keeps the dent; springs "
                 "towards rest, which the paper does not have, work against it. Where they win is "
                 "a matter of C/ks and F/ks alone. Here: the map of both by static solutions of "
                 "the second implementation, and runs of 50 s under load and 200 s without.");
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    softsim_status status =
        net != NULL && fill(net, tube, 1.0, &isotropic) && fill(net, tube, 2.0, &orthotropic)
            ? SOFTSIM_OK
            : SOFTSIM_ERROR_MEMORY;
    if (status != SOFTSIM_OK) {
        ss_zhong_net_destroy(&net);
        status = ss_memory_fault(error);
        return status;
    }
    const double limit = critical(&isotropic), other_limit = critical(&orthotropic);
    status = write_map(paper, &isotropic, &one, error);
    if (status == SOFTSIM_OK) {
        status = ss_paper_csv_open(paper, &csv, "density",
                                   "reading,force_n,time_s,u_m,shortest_edge", error);
    }
    if (status == SOFTSIM_OK) {
        status =
            ss_paper_csv_open(paper, &points, "density-runs",
                              "across,c_pa,ks_n_per_m,force_n,c_over_ks_per_m,u_m,left", error);
        if (status != SOFTSIM_OK) {
            ss_output_abandon(&csv);
        }
    }
    if (status != SOFTSIM_OK) {
        ss_zhong_net_destroy(&net);
        return status;
    }
    status = run_all(paper, net, tube, 1.0, limit, csv.file, points.file, &left[0], error);
    if (status == SOFTSIM_OK) {
        ss_page_text(&paper->page, "The same with C twice as stiff across the axis:");
        status =
            run_all(paper, net, tube, 2.0, other_limit, csv.file, points.file, &left[1], error);
    }
    ss_zhong_net_destroy(&net);
    if (status != SOFTSIM_OK) {
        ss_output_abandon(&csv);
        ss_output_abandon(&points);
        return status;
    }
    claim_map(paper, limit, one, left, other_limit);
    claim_loops(paper);
    status = ss_paper_csv_close(paper, &csv, "density", error);
    if (status == SOFTSIM_OK) {
        status = ss_paper_csv_close(paper, &points, "density-runs", error);
    } else {
        ss_output_abandon(&points);
    }
    return status == SOFTSIM_OK ? plot_map(paper, limit, error) : status;
}
