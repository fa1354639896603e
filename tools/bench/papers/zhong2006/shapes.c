/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Figures 7 to 11: what the constitutive coefficient rho and the sources make of the cylinder's
 * static shape under 1 N. Colours as the paper's: red and green portions.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/surface_picture.h"
#include "bench/papers/zhong2006/zhong2006.h"
#include "rt/memory.h"
#include "rt/vec.h"

static const uint32_t red = 0xd0605a, green = 0x6fae62, plain = 0xd8b9a0;
enum { NINE = 9 };

typedef enum material { ISOTROPIC, ACROSS_MORE, ALONG_MORE, BANDS, LOCAL, NINE_POINTS } material;

static const struct shape_case {
    const char *figure, *name, *title;
    material material;
} cases[] = {
    {"Fig. 7", "fig7", "isotropic, rho 0.05", ISOTROPIC},
    {"Fig. 8", "fig8", "anisotropic, rho 0.05 along the axis, 0.1 around it", ACROSS_MORE},
    {"Fig. 8", "fig8-swapped", "anisotropic the other way, rho 0.1 along the axis, 0.05 around it",
     ALONG_MORE},
    {"Fig. 9", "fig9", "inhomogeneous, bands of rho 0.05 (red) and 0.1 (green)", BANDS},
    {"Fig. 10", "fig10", "local, rho 1e-6 beyond 0.6 m of the contact (red)", LOCAL},
    {"Fig. 11", "fig11", "large range, sources and force on nine points (red)", NINE_POINTS},
};
enum { CASE_COUNT = sizeof cases / sizeof cases[0] };

typedef struct result {
    double depth, width;
    double u[SS_TUBE_POINTS][3];
} result;

/* ---- set-ups ---- */

static bool is_far(int32_t point)
{
    const int32_t rows = point / SS_TUBE_COLUMNS - SS_TUBE_CONTACT / SS_TUBE_COLUMNS;
    return fabs((double)rows) * 4.0 / (SS_TUBE_ROWS - 1) > 0.6;
}

/* Two rings of points to a band; the contact's is a green one. */
static bool is_green(int32_t point)
{
    return point / SS_TUBE_COLUMNS / 2 % 2 == 1;
}

static void set_up(material which, double rho[SS_TUBE_POINTS], ss_tube_setup *out)
{
    *out = (ss_tube_setup){.load = {{.point = SS_TUBE_CONTACT, .force = 1.0}}, .load_count = 1};
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        rho[i] = which == BANDS   ? (is_green(i) ? 0.1 : 0.05)
                 : which == LOCAL ? (is_far(i) ? 1e-6 : 0.05)
                                  : 0.05;
    }
    out->rho = which == BANDS || which == LOCAL ? rho : NULL;
    out->rho_along = which == ALONG_MORE ? 0.1 : 0.05;
    out->across = which == ACROSS_MORE ? 2.0 : which == ALONG_MORE ? 0.5 : 0.0;
    out->load[0].count = which == NINE_POINTS ? NINE : 0;
}

/* Length along the axis over which the contact's line is at least half as deep as the contact. */
static double range_of(const double (*u)[3])
{
    const double half = -0.5 * u[SS_TUBE_CONTACT][1], spacing = 4.0 / (SS_TUBE_ROWS - 1);
    double range = 0.0;
    for (int32_t i = 0; i + 1 < SS_TUBE_ROWS; ++i) {
        const double a = -u[i * SS_TUBE_COLUMNS][1] - half;
        const double b = -u[(i + 1) * SS_TUBE_COLUMNS][1] - half;
        const double share = a >= 0.0 && b >= 0.0 ? 1.0
                             : a < 0.0 && b < 0.0 ? 0.0
                                                  : fmax(a, b) / fabs(a - b);
        range += share * spacing;
    }
    return range;
}

/* The force on nine points that makes the contact as deep as `depth`, and the shape. */
static softsim_status match_depth(ss_zhong *zhong, const ss_tube *tube, ss_tube_setup *setup,
                                  double depth, result *out, softsim_error *error)
{
    enum { TRIES = 6 };
    softsim_status status = SOFTSIM_OK;
    double last_force = 1.0, last_depth = 0.0;
    setup->load[0].force = 3.0;
    for (int k = 0; status == SOFTSIM_OK && k < TRIES; ++k) {
        status = ss_tube_static(zhong->paper, tube, setup, "nine points", &out->depth, &out->width,
                                out->u, error);
        if (status != SOFTSIM_OK || isnan(out->depth) || fabs(out->depth / depth - 1.0) < 1e-4) {
            break;
        }
        /* Depth grows as a power of force: a secant in logarithms. */
        const double power =
            k == 0 ? 0.5 : log(out->depth / last_depth) / log(setup->load[0].force / last_force);
        last_force = setup->load[0].force;
        last_depth = out->depth;
        setup->load[0].force *= pow(depth / out->depth, 1.0 / power);
    }
    return status;
}

/* ---- pictures ---- */

/* Between the colours of a face's corners. */
static uint32_t colour_of(material which, const int32_t face[4])
{
    const int32_t corners = face[3] < 0 ? 3 : 4;
    uint32_t colour = 0;
    for (int shift = 16; shift >= 0; shift -= 8) {
        double sum = 0.0;
        for (int32_t k = 0; k < corners; ++k) {
            const bool is_first = which == BANDS ? is_green(face[k]) : !is_far(face[k]);
            const uint32_t of_corner = is_first ? (which == BANDS ? green : plain) : red;
            sum += (double)(of_corner >> shift & 255u) / corners;
        }
        colour |= (uint32_t)sum << shift;
    }
    return colour;
}

static softsim_status draw(ss_zhong *zhong, const ss_tube *tube, const struct shape_case *at,
                           const result *r, softsim_error *error)
{
    static const ss_surface_picture_view views[2] = {
        {{1.0, 0.12, 0.0}, {0.0, 1.0, 0.0}, "from the side"},
        {{0.65, 0.55, 0.9}, {0.0, 1.0, 0.0}, "from above and one end"}};
    static int32_t face[SS_TUBE_TRIANGLES][4], ring[SS_TUBE_COLUMNS], nine[NINE];
    static uint32_t colour[SS_TUBE_TRIANGLES];
    const bool is_coloured = at->material == BANDS || at->material == LOCAL;
    char name[48], caption[320];
    int32_t count = 0;
    for (int32_t t = 0; t < SS_TUBE_TRIANGLES; ++t) {
        if (!tube->is_grid) {
            memcpy(face[count], tube->triangle[t], sizeof tube->triangle[t]);
            face[count++][3] = -1;
        } else if (t % 2 == 0) { /* two triangles a cell */
            const int32_t row = t / 2 / SS_TUBE_COLUMNS, j = t / 2 % SS_TUBE_COLUMNS;
            const int32_t a = row * SS_TUBE_COLUMNS + j;
            const int32_t b = row * SS_TUBE_COLUMNS + (j + 1) % SS_TUBE_COLUMNS;
            const int32_t quad[4] = {b, a, a + SS_TUBE_COLUMNS, b + SS_TUBE_COLUMNS};
            memcpy(face[count++], quad, sizeof quad);
        }
    }
    for (int32_t f = 0; f < count; ++f) {
        colour[f] = colour_of(at->material, face[f]);
    }
    for (int32_t j = 0; j < SS_TUBE_COLUMNS; ++j) {
        ring[j] = SS_TUBE_CONTACT + j;
    }
    for (int32_t k = 0; k < NINE; ++k) {
        nine[k] = SS_TUBE_CONTACT + (k - NINE / 2) * SS_TUBE_COLUMNS;
    }
    const ss_surface_picture shape = {.node_count = SS_TUBE_POINTS,
                                      .face_count = count,
                                      .rest = (const double(*)[3])tube->position,
                                      .u = (const double(*)[3])r->u,
                                      .face = (const int32_t(*)[4])face,
                                      .colour = is_coloured ? colour : NULL,
                                      .ring_count = SS_TUBE_COLUMNS,
                                      .ring = ring,
                                      .mark_count = at->material == NINE_POINTS ? NINE : 0,
                                      .mark = nine,
                                      .pushed = SS_TUBE_CONTACT,
                                      .push = {0.0, -1.0, 0.0}};
    snprintf(name, sizeof name, "%s-%s", at->name, tube->name);
    snprintf(caption, sizeof caption,
             "%s, %s: %s. Contact %.3f m deep, its ring %.3f m wide (2 at rest). Dashed: the body "
             "at rest and the contact's ring.",
             at->figure, tube->name, at->title, r->depth, r->width);
    return ss_surface_picture_draw(zhong->paper, name, caption, &shape, views, 2, error);
}

static softsim_status write_shape(ss_zhong *zhong, const ss_tube *tube, const struct shape_case *at,
                                  const result *r, softsim_error *error)
{
    ss_output csv;
    char name[48];
    snprintf(name, sizeof name, "%s-%s", at->name, tube->name);
    const softsim_status status =
        ss_paper_csv_open(zhong->paper, &csv, name, "point,x,y,z,ux,uy,uz", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        fprintf(csv.file, "%d,%.8g,%.8g,%.8g,%.8g,%.8g,%.8g\n", i, tube->position[i][0],
                tube->position[i][1], tube->position[i][2], r->u[i][0], r->u[i][1], r->u[i][2]);
    }
    return ss_paper_csv_close(zhong->paper, &csv, name, error);
}

/* ---- claims ---- */

static double largest_far(const result *r)
{
    double largest = 0.0;
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        largest = is_far(i) ? fmax(largest, ss_norm3(r->u[i])) : largest;
    }
    return largest;
}

static void compare_with_isotropic(ss_zhong *zhong, const ss_tube *tube,
                                   const struct shape_case *at, const result *r,
                                   const result *isotropic)
{
    ss_paper *paper = zhong->paper;
    double difference = 0.0;
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        double d[3];
        ss_sub3(d, r->u[i], isotropic->u[i]);
        difference = fmax(difference, ss_norm3(d));
    }
    if (at->material == ACROSS_MORE) {
        ss_claim_at_least(paper, at->figure, SS_FROM_PAPER, 0.01, isotropic->width - r->width,
                          "%s: narrower around the deformation than the isotropic one by, m",
                          tube->name);
        ss_claim_at_least(paper, at->figure, SS_FROM_PAPER, 0.01, r->depth - isotropic->depth,
                          "%s: deformed more in the radial direction than the isotropic one by, m",
                          tube->name);
    } else if (at->material == ALONG_MORE) {
        ss_claim_at_least(paper, at->figure, SS_FROM_PAPER, 0.01, r->width - isotropic->width,
                          "%s: with the two swapped it is wider than the isotropic one by, m",
                          tube->name);
    } else if (at->material == BANDS) {
        ss_claim_at_least(paper, at->figure, SS_FROM_PAPER, 0.02, difference,
                          "%s: deformed otherwise than the isotropic one (largest difference of a "
                          "point, m)",
                          tube->name);
    } else if (at->material == LOCAL) {
        ss_claim_at_most(paper, at->figure, SS_FROM_PAPER, 1e-3, largest_far(r) / r->depth,
                         "%s: the red portions are not deformed (largest displacement there over "
                         "the contact's)",
                         tube->name);
    }
}

/* The flux densities of several sources: each cell's own, over its Qhat, added by equal shares; the
 * mean Qhat stands for the source's. Added as potentials instead, |.| of their sum would cancel
 * between the cells. */
static bool add_sources(const ss_tube *tube, ss_zhong_net *net)
{
    double *kap = calloc((size_t)net->edge_count, sizeof *kap), strain = 0.0;
    ss_zhong_net *one = ss_tube_net(tube, NULL, 0.0);
    bool is_good = kap != NULL && one != NULL;
    for (int k = -NINE / 2; is_good && k <= NINE / 2; ++k) {
        memset(one->is_source, 0, (size_t)one->node_count);
        one->is_source[SS_TUBE_CONTACT + k * SS_TUBE_COLUMNS] = 1;
        is_good = ss_zhong_net_solve(one);
        for (int32_t e = 0; is_good && e < one->edge_count; ++e) {
            kap[e] += one->flux[e] / one->flux_strain / NINE;
        }
        strain += one->flux_strain / NINE;
    }
    for (int32_t e = 0; is_good && e < net->edge_count; ++e) {
        net->flux[e] = kap[e] * strain;
    }
    net->flux_strain = strain;
    ss_zhong_net_destroy(&one);
    free(kap);
    return is_good;
}

/* Fig. 11: the force spread with the sources, at the isotropic one's depth. */
static softsim_status nine_claims(ss_zhong *zhong, const ss_tube *tube, const ss_tube_setup *setup,
                                  const result *r, const result *isotropic, softsim_error *error)
{
    static double force[SS_TUBE_POINTS][3], u[SS_TUBE_POINTS][3];
    double ks[SS_TUBE_POINTS];
    ss_paper *paper = zhong->paper;
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    memset(force, 0, sizeof force);
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        ks[i] = SS_TUBE_KS;
    }
    for (int k = -NINE / 2; k <= NINE / 2; ++k) {
        force[SS_TUBE_CONTACT + k * SS_TUBE_COLUMNS][1] = -setup->load[0].force / NINE;
    }
    if (net == NULL || !add_sources(tube, net) ||
        isnan(ss_zhong_net_static(net, SS_TUBE_MODULUS, ks, (const double(*)[3])force, u))) {
        ss_zhong_net_destroy(&net);
        return ss_memory_fault(error);
    }
    ss_zhong_net_destroy(&net);
    ss_claim_near(paper, "Fig. 11", SS_FROM_CODE, -u[SS_TUBE_CONTACT][1], r->depth,
                  SS_CODE_TOLERANCE, "%s: nine sources share %.3g N: depth of the contact, m",
                  tube->name, setup->load[0].force);
    ss_claim_at_least(paper, "Fig. 11", SS_FROM_PAPER,
                      1.2 * range_of((const double(*)[3])isotropic->u),
                      range_of((const double(*)[3])r->u),
                      "%s: as deep as the one of Fig. 7, the deformation ranges farther: length at "
                      "half depth along the axis, m",
                      tube->name);
    return SOFTSIM_OK;
}

/* The depth and the ring's width as the reference network has them. */
static softsim_status reference_claims(ss_zhong *zhong, const ss_tube *tube,
                                       const struct shape_case *at, const ss_tube_setup *setup,
                                       const result *r, softsim_error *error)
{
    double rho[SS_TUBE_POINTS], width;
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        rho[i] = setup->rho != NULL ? setup->rho[i] : setup->rho_along;
    }
    ss_zhong_net *net = ss_tube_net(tube, rho, setup->across);
    if (net == NULL) {
        return ss_memory_fault(error);
    }
    const double depth = ss_tube_net_static(net, 1.0, NULL, &width);
    ss_zhong_net_destroy(&net);
    ss_claim_near(zhong->paper, at->figure, SS_FROM_CODE, depth, r->depth, SS_CODE_TOLERANCE,
                  "%s: %s: depth of the contact at 1 N, m", tube->name, at->title);
    ss_claim_near(zhong->paper, at->figure, SS_FROM_CODE, width, r->width, SS_CODE_TOLERANCE,
                  "%s: %s: width of its ring, m", tube->name, at->title);
    return SOFTSIM_OK;
}

static softsim_status case_claims(ss_zhong *zhong, const ss_tube *tube, const struct shape_case *at,
                                  const ss_tube_setup *setup, const result *r,
                                  const result *isotropic, softsim_error *error)
{
    compare_with_isotropic(zhong, tube, at, r, isotropic);
    return at->material == NINE_POINTS ? nine_claims(zhong, tube, setup, r, isotropic, error)
                                       : reference_claims(zhong, tube, at, setup, r, error);
}

static softsim_status run_case(ss_zhong *zhong, const ss_tube *tube, const struct shape_case *at,
                               result *r, const result *isotropic, softsim_error *error)
{
    double rho[SS_TUBE_POINTS];
    ss_tube_setup setup;
    char what[128];
    snprintf(what, sizeof what, "%s: %s", at->figure, at->title);
    set_up(at->material, rho, &setup);
    softsim_status status =
        at->material == NINE_POINTS
            ? match_depth(zhong, tube, &setup, isotropic->depth, r, error)
            : ss_tube_static(zhong->paper, tube, &setup, what, &r->depth, &r->width, r->u, error);
    if (status != SOFTSIM_OK || isnan(r->depth)) {
        return status;
    }
    status = case_claims(zhong, tube, at, &setup, r, isotropic, error);
    if (status == SOFTSIM_OK) {
        status = draw(zhong, tube, at, r, error);
    }
    return status == SOFTSIM_OK ? write_shape(zhong, tube, at, r, error) : status;
}

/* ---- two more lines about the isotropic cylinder ---- */

static softsim_status one_way_claim(ss_zhong *zhong, softsim_error *error)
{
    static ss_tube tube;
    const ss_tube_setup setup = {.load = {{.point = SS_TUBE_CONTACT, .force = 0.25}},
                                 .load_count = 1};
    double depth, width;
    softsim_status status = ss_tube_init(zhong->paper, false, true, &tube, error);
    if (status == SOFTSIM_OK) {
        status = ss_tube_static(zhong->paper, &tube, &setup, "diagonals all one way", &depth,
                                &width, NULL, error);
    }
    if (status == SOFTSIM_OK && tube.is_there) {
        ss_zhong_net *net = ss_tube_net(&tube, NULL, 0.0);
        const double reference =
            net != NULL ? ss_tube_net_static(net, 0.25, NULL, NULL) : (double)NAN;
        ss_zhong_net_destroy(&net);
        ss_claim_near(zhong->paper, "Fig. 7", SS_FROM_CODE, reference, depth, SS_CODE_TOLERANCE,
                      "triangles with all diagonals one way: static depth at 0.25 N, m (how a mesh "
                      "is cut matters by 6 %%)");
    }
    ss_tube_fini(&tube);
    return status;
}

static softsim_status per_area_claim(ss_zhong *zhong, const ss_tube *tube, softsim_error *error)
{
    double ks[SS_TUBE_POINTS], mean = 0.0, depth, width;
    ss_zhong_net *net = ss_tube_net(tube, NULL, 0.0);
    if (net == NULL) {
        return ss_memory_fault(error);
    }
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        mean += net->area[i] / SS_TUBE_POINTS;
    }
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        ks[i] = SS_TUBE_KS * net->area[i] / mean;
    }
    const double reference = ss_tube_net_static(net, 0.25, ks, NULL);
    ss_zhong_net_destroy(&net);
    const ss_tube_setup setup = {.load = {{.point = SS_TUBE_CONTACT, .force = 0.25}},
                                 .load_count = 1,
                                 .is_per_area = true,
                                 .mean_area = mean};
    const softsim_status status = ss_tube_static(zhong->paper, tube, &setup, "densities by area",
                                                 &depth, &width, NULL, error);
    if (status == SOFTSIM_OK && !isnan(depth)) {
        ss_claim_near(zhong->paper, "Fig. 7", SS_FROM_CODE, reference, depth, SS_CODE_TOLERANCE,
                      "%s: mass, damping and rest stiffness by area: static depth at 0.25 N, m",
                      tube->name);
    }
    return status;
}

softsim_status ss_zhong_materials(ss_paper *paper, softsim_error *error)
{
    ss_zhong *zhong = paper->shared;
    static result isotropic, other;
    ss_page_text(
        &paper->page,
        "The paper: an isotropic cylinder (Fig. 7); a coefficient of 0.1 on the segment "
        "lines and 0.05 along the axis makes it narrower around the deformation (Fig. 8); "
        "red portions with 0.05 and green ones with 0.1 deform differently (Fig. 9); red "
        "portions with a very small coefficient do not deform (Fig. 10); sources on "
        "several points give a larger range (Fig. 11). Here: 1 N, static shapes. The paper "
        "does not say where its bands lie: bands of two rings are taken.");
    softsim_status status = SOFTSIM_OK;
    for (int k = 0; status == SOFTSIM_OK && k < 2; ++k) {
        const ss_tube *tube = &zhong->tube[k];
        for (int32_t c = 0; tube->is_there && status == SOFTSIM_OK && c < CASE_COUNT; ++c) {
            status =
                run_case(zhong, tube, &cases[c], c == 0 ? &isotropic : &other, &isotropic, error);
            ss_paper_progress(paper, 0.5 * k + 0.5 * (c + 1) / (CASE_COUNT + 1));
        }
        if (status == SOFTSIM_OK && tube->is_there) {
            status = per_area_claim(zhong, tube, error);
        }
    }
    return status == SOFTSIM_OK ? one_way_claim(zhong, error) : status;
}
