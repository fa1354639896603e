/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * tools/bench, reports on papers: a claim passes only within its bound and a number that is none
 * never does; claims.csv has its columns; the second implementation of the network gives what can
 * be solved by hand, and the program gives the same; pictures and pages hold what they are given;
 * wrong arguments are refused.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/bench.h"
#include "bench/core/surface_picture.h"
#include "bench/papers/paper.h"
#include "bench/papers/zhong2006/motion.h"
#include "bench/papers/zhong2006/net.h"
#include "bench/papers/zhong2006/zhong2006.h"
#include "common/effort.h"
#include "common/folder_fixture.h"
#include "rt/vec.h"

#define assert_near(a, b, share) assert_true(fabs((a) - (b)) <= (share)*fabs(b))

static ss_paper paper;
static softsim_error error;

static void start(void)
{
    memset(&paper, 0, sizeof paper);
    memset(&error, 0, sizeof error);
    paper.name = "zhong2006";
    paper.folder = folder;
    snprintf(paper.temporary, sizeof paper.temporary, "%s", folder);
    snprintf(paper.bin, sizeof paper.bin, "%s", BIN_DIR);
}

/* ---- claims ---- */

TEST(claims_pass_within_their_bounds_only)
{
    start();
    const double none = (double)NAN;
    ss_claim_near(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, 1.0199, 0.02, "a");
    ss_claim_near(&paper, "Fig. 4", SS_FROM_PAPER, -1.0, -0.9801, 0.02, "a");
    ss_claim_at_most(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, 1.0, "a");
    ss_claim_at_least(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, 1.0, "a");
    assert_int_equal(ss_paper_count(&paper, SS_CLAIM_PASS), 4);
    ss_claim_near(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, 1.0201, 0.02, "a");
    ss_claim_near(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, 0.9799, 0.02, "a");
    ss_claim_near(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, none, 0.02, "a");
    ss_claim_near(&paper, "Fig. 4", SS_FROM_PAPER, none, 1.0, 0.02, "a");
    ss_claim_at_most(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, 1.0001, "a");
    ss_claim_at_most(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, none, "a");
    ss_claim_at_least(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, 0.9999, "a");
    ss_claim_at_least(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, none, "a");
    assert_int_equal(ss_paper_count(&paper, SS_CLAIM_PASS), 4);
    assert_int_equal(ss_paper_count(&paper, SS_CLAIM_FAIL), 8);
    ss_claim_add(&paper, "eq. 4", SS_FROM_PAPER, SS_CLAIM_DIFFERS, "x", "y", "a");
    assert_int_equal(ss_paper_count(&paper, SS_CLAIM_DIFFERS), 1);
}

TEST(the_list_of_claims_is_bounded)
{
    start();
    for (int k = 0; k < SS_PAPER_MAX_CLAIMS + 10; ++k) {
        ss_claim_at_most(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, 0.0, "claim %d", k);
        ss_paper_miss(&paper, "why", "thing %d", k);
    }
    assert_int_equal(paper.claim_count, SS_PAPER_MAX_CLAIMS);
    assert_int_equal(paper.missing_count, SS_PAPER_MAX_MISSING);
}

TEST(claims_are_written_with_tolerance_and_source)
{
    char text[2048];
    start();
    ss_claim_near(&paper, "Fig. 4", SS_FROM_CODE, 0.5, 0.501, 0.02, "depth, \"U\", %d N", 3);
    ss_claim_add(&paper, "eq. 4", SS_FROM_PAPER, SS_CLAIM_DIFFERS, "back", "stays: F cancels",
                 "returns");
    ss_claim_at_most(&paper, "eq. 27", SS_FROM_CLOSED_FORM, 1.0, 2.0, "small");
    assert_int_equal(ss_paper_write_claims(&paper, &error), SOFTSIM_OK);
    read_text("claims.csv", text, sizeof text);
    assert_string_equal(
        text,
        "paper,figure,claim,expected,measured,tolerance,source,result\n"
        "zhong2006,Fig. 4,\"depth, \"\"U\"\", 3 N\",0.5,0.501 (+0.2 %),0.02,independent,pass\n"
        "zhong2006,eq. 4,returns,back,stays: F cancels,,paper,differs\n"
        "zhong2006,eq. 27,small,at most 1,2,,closed form,fail\n");
}

TEST(claims_write_no_share_of_zero_and_thousands_in_full)
{
    start();
    ss_claim_near(&paper, "Fig. 4", SS_FROM_CLOSED_FORM, 0.0, 0.0, 0.02, "still");
    assert_string_equal(paper.claim[0].measured, "0");
    assert_int_equal(paper.claim[0].result, SS_CLAIM_PASS);
    ss_claim_at_least(&paper, "Fig. 12", SS_FROM_PAPER, 9000.0, 92370.4, "rate");
    assert_string_equal(paper.claim[1].expected, "at least 9000");
    assert_string_equal(paper.claim[1].measured, "92370");
    ss_claim_at_most(&paper, "Fig. 4", SS_FROM_CLOSED_FORM, 1e-6, 5.551e-16, "error");
    assert_string_equal(paper.claim[2].expected, "at most 1e-06");
    assert_string_equal(paper.claim[2].measured, "5.551e-16");
}

TEST(the_closing_note_names_what_does_not_pass_with_its_search)
{
    char text[8192];
    start();
    assert_int_equal(ss_page_open(&paper.page, folder, "page", "title", &error), SOFTSIM_OK);
    ss_claim_search(&paper, "of no claim"); /* does nothing */
    ss_claim_at_most(&paper, "Fig. 4", SS_FROM_PAPER, 1.0, 0.5, "good");
    ss_claim_search(&paper, "search one");
    ss_claim_at_most(&paper, "Fig. 6", SS_FROM_PAPER, 1.0, 2.0, "too large");
    ss_claim_search(&paper, "tried %d ways", 7);
    ss_claim_add(&paper, "eq. 9", SS_FROM_PAPER, SS_CLAIM_DIFFERS, "x", "y", "words");
    ss_paper_write_verdict(&paper);
    assert_int_equal(ss_page_close(&paper.page, &error), SOFTSIM_OK);
    read_text("page.html", text, sizeof text);
    assert_non_null(strstr(text, "3 claims: 1 pass, 1 fail, 1 differ. Those that do not pass:"));
    const char *fail = strstr(text, "<td>fail</td><td>Fig. 6</td><td>too large</td>");
    assert_non_null(fail);
    assert_non_null(strstr(fail, "tried 7 ways"));
    assert_non_null(strstr(fail, "<td>differs</td><td>eq. 9</td><td>words</td>"));
    assert_null(strstr(text, "search one"));
}

TEST(the_page_shows_each_claim_once)
{
    char text[8192];
    start();
    assert_int_equal(ss_page_open(&paper.page, folder, "page", "title", &error), SOFTSIM_OK);
    ss_claim_at_most(&paper, "eq. 27", SS_FROM_PAPER, 1.0, 2.0, "first <one>");
    ss_paper_show_claims(&paper);
    ss_claim_at_most(&paper, "eq. 27", SS_FROM_PAPER, 1.0, 0.5, "second");
    ss_paper_show_claims(&paper);
    ss_paper_show_claims(&paper);
    ss_output csv;
    assert_int_equal(ss_paper_csv_open(&paper, &csv, "curve", "a,b", &error), SOFTSIM_OK);
    assert_int_equal(ss_paper_csv_close(&paper, &csv, "curve", &error), SOFTSIM_OK);
    assert_int_equal(ss_page_close(&paper.page, &error), SOFTSIM_OK);
    read_text("page.html", text, sizeof text);
    const char *first = strstr(text, "first &lt;one&gt;"), *second = strstr(text, "second");
    assert_non_null(first);
    assert_non_null(second);
    assert_null(strstr(first + 1, "first &lt;one&gt;"));
    assert_null(strstr(second + 1, "second"));
    assert_non_null(strstr(text, "<a href=\"curve.csv\">"));
}

static softsim_status works(ss_paper *of, softsim_error *fault)
{
    (void)fault;
    ++*(int32_t *)of->shared;
    ss_claim_at_most(of, "eq. 1", SS_FROM_PAPER, 1.0, 0.5, "claim %d", *(int32_t *)of->shared);
    return SOFTSIM_OK;
}

static softsim_status stops(ss_paper *of, softsim_error *fault)
{
    softsim_error_add(fault, SOFTSIM_ERROR_SYSTEM, "stopped");
    ++*(int32_t *)of->shared;
    return SOFTSIM_ERROR_SYSTEM;
}

TEST(sections_run_in_order_up_to_the_first_that_fails)
{
    static const ss_paper_section sections[] = {
        {"One", works, 1.0}, {"Two", works, 2.0}, {"Three", stops, 4.0}, {"Four", works, 8.0}};
    char text[8192];
    int32_t runs = 0;
    start();
    paper.shared = &runs;
    assert_int_equal(ss_page_open(&paper.page, folder, "page", "title", &error), SOFTSIM_OK);
    assert_int_equal(ss_paper_run_sections(&paper, 4, sections, &error), SOFTSIM_ERROR_SYSTEM);
    assert_int_equal(runs, 3);
    assert_true(paper.weight_all == 15.0);
    assert_true(paper.weight_done == 7.0);
    ss_paper_write_missing(&paper);
    ss_paper_write_verdict(&paper);
    ss_paper_miss(&paper, "not <built>", "a model");
    ss_paper_write_missing(&paper);
    assert_int_equal(ss_page_close(&paper.page, &error), SOFTSIM_OK);
    read_text("page.html", text, sizeof text);
    static const char *const order[] = {"<h2>One</h2>",
                                        "claim 1",
                                        "<h2>Two</h2>",
                                        "claim 2",
                                        "<h2>Three</h2>",
                                        "<h2>Verdict</h2>",
                                        "2 claims: 2 pass, 0 fail, 0 differ.",
                                        "<a href=\"claims.csv\">",
                                        "<h2>Not in this program</h2>",
                                        "a model",
                                        "not &lt;built&gt;"};
    const char *at = text;
    for (size_t k = 0; k < sizeof order / sizeof *order; ++k) {
        at = strstr(at, order[k]);
        if (at == NULL) {
            fail_msg("no '%s' in its place", order[k]);
            return;
        }
    }
    assert_null(strstr(text, "Four"));
}

/* ---- the report's reference network ---- */

static const double edge = 0.3;

static ss_zhong_net *make_hexagon(int32_t triangle[6][3], double rho)
{
    double position[7][3] = {{0.0, 0.0, 0.0}};
    for (int k = 0; k < 6; ++k) {
        ss_set3(position[1 + k], edge * cos(k * SS_PI / 3.0), edge * sin(k * SS_PI / 3.0), 0.0);
        const int32_t corner[3] = {0, 1 + k, 1 + (k + 1) % 6};
        memcpy(triangle[k], corner, sizeof corner);
    }
    ss_zhong_net *net = ss_zhong_net_triangles(7, (const double(*)[3])position, 6,
                                               (const int32_t(*)[3])triangle, NULL, 0.0);
    assert_non_null(net);
    for (int32_t i = 0; i < 7; ++i) {
        net->rho[i] = rho;
        net->is_held[i] = i > 0;
        net->is_source[i] = i == 0;
    }
    assert_true(ss_zhong_net_solve(net));
    return net;
}

TEST(a_hexagon_is_as_solved_by_hand)
{
    int32_t triangle[6][3];
    ss_zhong_net *net = make_hexagon(triangle, 0.05);
    assert_int_equal(net->edge_count, 12);
    assert_near(net->area[0], sqrt(3.0) * edge * edge / 2.0, 1e-12);
    assert_near(net->potential[0], edge * edge / (4.0 * 0.05), 1e-12);
    assert_near(net->flux_strain, 1.5 * edge * edge, 1e-12);
    for (int32_t e = 0; e < net->edge_count; ++e) {
        const bool is_spoke = net->edge[e][0] == 0;
        assert_near(net->conductance[e], (is_spoke ? 1.0 : 0.5) / sqrt(3.0), 1e-12);
        assert_true(is_spoke ? fabs(net->flux[e] - 0.25) < 1e-12 : net->flux[e] == 0.0);
    }
    /* ks z + 3 E z^3 / (4 h^2) = F */
    double ks[7], force[7][3] = {{0.0}}, u[7][3];
    for (int i = 0; i < 7; ++i) {
        ks[i] = 0.3;
    }
    force[0][2] = 0.5;
    const double current = ss_zhong_net_static(net, 7.0, ks, (const double(*)[3])force, u);
    const double z = u[0][2];
    assert_near(0.3 * z + 0.75 * 7.0 * z * z * z / (edge * edge), 0.5, 1e-9);
    assert_near(current, 7.0 * ss_zhong_net_strain(net, (const double(*)[3])u) / net->flux_strain,
                1e-9);
    ss_zhong_net_destroy(&net);
    assert_null(net);
}

/* At its bound the cell's current is K/ghat: z = F/(ks + 6 rho K/h^2). */
TEST(a_bounded_hexagon_is_as_solved_by_hand)
{
    int32_t triangle[6][3];
    const double rho = 0.05, bound = 0.2;
    ss_zhong_net *net = make_hexagon(triangle, rho);
    double ks[7], force[7][3] = {{0.0}}, u[7][3], shape[7][3];
    for (int i = 0; i < 7; ++i) {
        ks[i] = 0.3;
    }
    force[0][2] = 0.5;
    net->most_current = bound / net->potential[0];
    const double current = ss_zhong_net_static(net, 7.0, ks, (const double(*)[3])force, u);
    assert_near(current, net->most_current, 1e-9);
    assert_true(net->current == current);
    assert_near(u[0][2], 0.5 / (0.3 + 6.0 * rho * bound / (edge * edge)), 1e-9);
    assert_true(ss_zhong_net_shape(net, current, ks, (const double(*)[3])force, shape));
    assert_near(shape[0][2], u[0][2], 1e-12);
    ss_zhong_net_destroy(&net);
}

/* In a regular tetrahedron the face between two cells stands across their edge, so that areas times
 * lengths add up to three volumes. */
TEST(a_tetrahedron_parts_its_volume_among_cells_and_faces)
{
    static const double position[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    static const int32_t tetrahedron[1][4] = {{0, 1, 2, 3}};
    const double volume = 8.0 / 3.0;
    double faces = 0.0, cells = 0.0;
    ss_zhong_net *net = ss_zhong_net_tetrahedra(4, position, 1, tetrahedron);
    assert_non_null(net);
    assert_int_equal(net->edge_count, 6);
    for (int32_t e = 0; e < 6; ++e) {
        faces += net->conductance[e] * net->length[e] * net->length[e];
        cells += e < 4 ? net->area[e] : 0.0;
    }
    assert_near(faces, 3.0 * volume, 1e-12);
    assert_near(cells, volume, 1e-12);
    ss_zhong_net_destroy(&net);
}

TEST(a_tube_has_the_printed_coefficients)
{
    /* Rings at uneven heights; across twice as much. */
    static const double height[4] = {0.0, 0.5, 0.8, 1.6};
    double position[4 * 6][3];
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 6; ++j) {
            ss_set3(position[6 * i + j], sin(j * SS_PI / 3.0), cos(j * SS_PI / 3.0), height[i]);
        }
    }
    ss_zhong_net *net = ss_zhong_net_tube(4, 6, (const double(*)[3])position, 2.0);
    assert_non_null(net);
    assert_int_equal(net->edge_count, 4 * 6 + 3 * 6);
    for (int32_t e = 0; e < net->edge_count; ++e) {
        const int32_t i = net->edge[e][0], j = net->edge[e][1], row = i / 6;
        const double du = row < 3 ? height[row + 1] - height[row] : 0.0;
        const double before = row > 0 ? height[row] - height[row - 1] : 0.0;
        const double dw = 1.0; /* chord of 60 degrees */
        if (j / 6 != row) {    /* (14) times S, from either side */
            const double s = 0.25 * (before + du) * 2.0 * dw;
            assert_near(net->conductance[e], dw / du, 1e-12);
            if (row > 0) {
                assert_near(net->conductance[e], s * 2.0 / (du * (before + du)), 1e-12);
            }
            assert_near(net->ratio[e], 1.0, 1e-12);
        } else { /* half a cell at the rims, times across */
            assert_near(net->conductance[e], 2.0 * 0.5 * (before + du) / dw, 1e-12);
            assert_near(net->ratio[e], 2.0, 1e-12);
        }
    }
    ss_zhong_net_destroy(&net);
}

TEST(the_direction_counts_on_triangles)
{
    static const double position[4][3] = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 0, 1}};
    static const int32_t triangle[2][3] = {{0, 2, 1}, {2, 3, 1}};
    static const double axis[3] = {0, 0, 1};
    ss_zhong_net *net = ss_zhong_net_triangles(4, position, 2, triangle, axis, 3.0);
    ss_zhong_net *plain = ss_zhong_net_triangles(4, position, 2, triangle, NULL, 3.0);
    assert_non_null(net);
    assert_non_null(plain);
    for (int32_t e = 0; e < net->edge_count; ++e) {
        const int32_t i = net->edge[e][0], j = net->edge[e][1];
        const double ratio = i + j == 1 || i + j == 5 ? 1.0 : i + j == 3 ? 2.0 : 3.0;
        assert_near(net->ratio[e], ratio, 1e-12);
        assert_near(net->conductance[e], ratio * plain->conductance[e], 1e-12);
    }
    ss_zhong_net_destroy(&net);
    ss_zhong_net_destroy(&plain);
}

TEST(an_indefinite_matrix_is_refused)
{
    double good[4] = {4.0, 0.0, 2.0, 3.0}, b[4] = {2.0, 1.0, 8.0, 8.0};
    double bad[4] = {1.0, 0.0, 2.0, 1.0};
    assert_true(ss_zhong_cholesky(2, good, 2, b));
    assert_near(b[0], 0.5, 1e-12); /* 4 x + 2 y = 2, 2 x + 3 y = 1 */
    assert_true(fabs(b[1]) < 1e-12);
    assert_near(b[2], 1.0, 1e-12);
    assert_near(b[3], 2.0, 1e-12);
    assert_false(ss_zhong_cholesky(2, bad, 1, b));
}

/* ---- laws ---- */

TEST(hookes_law_is_the_isotropic_one_where_moduli_agree)
{
    double c[6][6];
    const double young = 60.0, nu = 0.3;
    const double mu = 0.5 * young / (1.0 + nu), lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
    assert_true(ss_zhong_hooke(young, young, c));
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            assert_near(c[i][j], lambda + (i == j ? 2.0 * mu : 0.0), 1e-12);
        }
        assert_near(c[3 + i][3 + i], mu, 1e-12);
    }
    assert_true(ss_zhong_hooke(60.0, 120.0, c));
    assert_true(c[0][0] < c[1][1] && fabs(c[0][1] - c[1][0]) < 1e-12);
}

static double hexagon_depth(ss_zhong_source source, double force, double ks, double *out_left)
{
    int32_t triangle[6][3];
    ss_zhong_net *net = make_hexagon(triangle, 0.05);
    ss_zhong_law law = {
        .source = source, .modulus = 7.0, .mass = 1.0, .damping = 2.0, .rest_stiffness = ks};
    ss_zhong_motion motion;
    assert_true(ss_zhong_hooke(60.0, 60.0, law.tensor));
    assert_true(ss_zhong_motion_init(&motion, net, &law, 0, 6, (const int32_t(*)[3])triangle));
    ss_set3(motion.axis, 1.0, 0.0, 0.0); /* not the hexagon's normal */
    motion.force[2] = force;
    ss_zhong_motion_run(&motion, 20000, 0.01);
    const double depth = motion.u[0][2];
    motion.force[2] = 0.0;
    ss_zhong_motion_run(&motion, 20000, 0.01);
    *out_left = motion.u[0][2];
    ss_zhong_motion_fini(&motion);
    ss_zhong_net_destroy(&net);
    return depth;
}

TEST(the_closure_returns_and_the_work_of_the_force_cancels)
{
    SKIP_WHERE_REPEATED();
    double left;
    const double z = hexagon_depth(SS_ZHONG_CLOSURE, 0.5, 0.3, &left);
    assert_near(0.3 * z + 0.75 * 7.0 * z * z * z / (edge * edge), 0.5, 1e-9);
    assert_true(fabs(left) < 1e-9);
    /* F z / A on one side, F on the other: z^2 = h^2 sqrt 3 / 3. */
    for (int k = 0; k < 2; ++k) {
        assert_near(hexagon_depth(SS_ZHONG_WORK, k == 0 ? 0.1 : 1.0, 0.0, &left),
                    edge / sqrt(sqrt(3.0)), 1e-6);
        assert_near(left, edge / sqrt(sqrt(3.0)), 1e-2);
    }
    /* The linear strain of a point pushed out is shear alone: I = mu z^2 / (3 h^2 / 4). */
    const double pushed = hexagon_depth(SS_ZHONG_DENSITY, 0.5, 0.0, &left);
    const double mu = 0.5 * 60.0 / 1.3;
    const double current = mu * pushed * pushed / (0.75 * edge * edge);
    assert_near(1.5 * current * pushed, 0.5, 1e-6);
}

/* ---- the program ---- */

TEST(what_the_program_refuses_is_told)
{
    ss_trial_body body;
    char reason[256];
    start();
    assert_int_equal(ss_trial_look(&paper, "  mesh: none.msh\n  units: m\n", &body, reason, &error),
                     SOFTSIM_OK);
    assert_int_equal(body.node_count, 0);
    assert_non_null(strstr(reason, "none.msh"));
    assert_null(strstr(reason, "scene.yaml"));
}

TEST(the_program_bends_the_cylinder_as_the_second_code_does)
{
    SKIP_WHERE_REPEATED();
    static ss_tube tube;
    static double u[SS_TUBE_POINTS][3];
    double depth, width, reference_width;
    start();
    assert_int_equal(ss_tube_init(&paper, false, false, &tube, &error), SOFTSIM_OK);
    assert_true(tube.is_there);
    const ss_tube_setup setup = {.load = {{.point = SS_TUBE_CONTACT, .force = 1.0}},
                                 .load_count = 1};
    assert_int_equal(ss_tube_static(&paper, &tube, &setup, "it", &depth, &width, u, &error),
                     SOFTSIM_OK);
    ss_zhong_net *net = ss_tube_net(&tube, NULL, 0.0);
    assert_non_null(net);
    assert_near(ss_tube_net_static(net, 1.0, NULL, &reference_width), depth, 1e-5);
    assert_near(reference_width, width, 1e-5);
    assert_true(-u[SS_TUBE_CONTACT][1] == depth);
    ss_zhong_net_destroy(&net);
    ss_tube_fini(&tube);
    ss_tube_fini(&tube);
}

/* ---- pictures ---- */

TEST(faces_are_drawn_from_far_to_near)
{
    static const double rest[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                      {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    static const double u[8][3] = {{0}};
    static const int32_t face[2][4] = {{4, 5, 6, 7}, {0, 1, 2, -1}};
    static const uint32_t colour[2] = {0xff0000, 0x0000ff};
    static const ss_surface_picture_view view = {{0, 0, 1}, {0, 1, 0}, "above"};
    const ss_surface_picture shape = {.node_count = 8,
                                      .face_count = 2,
                                      .rest = rest,
                                      .u = u,
                                      .face = face,
                                      .colour = colour,
                                      .pushed = -1};
    char text[8192];
    start();
    assert_int_equal(ss_page_open(&paper.page, folder, "page", "title", &error), SOFTSIM_OK);
    assert_int_equal(ss_surface_picture_draw(&paper, "faces", "caption", &shape, &view, 1, &error),
                     SOFTSIM_OK);
    ss_page_abandon(&paper.page);
    read_text("faces.gp", text, sizeof text);
    const char *far = strstr(text, "polygon from 0,0 to 1,0 to 1,1 to 0,0 ");
    const char *near = strstr(text, "polygon from 0,0 to 1,0 to 1,1 to 0,1 to 0,0 ");
    assert_non_null(far);
    assert_non_null(near);
    assert_true(far < near);
    assert_non_null(strstr(far, "fc rgb '#0000"));
    /* Six edges of the two faces are their outline; none is shared. */
    int lines = 0;
    for (const char *at = strstr(text, "$outline"); (at = strstr(at, "\n\n")) != NULL; ++at) {
        ++lines;
    }
    assert_true(lines >= 7);
}

/* ---- arguments ---- */

static int run_quietly(int argc, char **argv)
{
    const int kept = divert(stderr, "/dev/null");
    const int result = ss_report_paper.run(argc, argv);
    restore(stderr, kept);
    return result;
}

TEST(wrong_arguments_are_refused)
{
    char program[] = "softsim-bench paper", unknown[] = "zhong2007", known[] = "zhong2006";
    char *none[] = {program, NULL}, *wrong[] = {program, unknown, NULL};
    char option[] = "--fast", out[] = "--out", nowhere[] = "/dev/null/report";
    char *odd[] = {program, known, option, NULL}, *lost[] = {program, known, out, nowhere, NULL};
    assert_int_equal(run_quietly(1, none), 2);
    assert_int_equal(run_quietly(2, wrong), 2);
    assert_int_equal(run_quietly(3, odd), 2);
    assert_int_equal(run_quietly(4, lost), 1);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
