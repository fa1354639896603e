/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "bench/papers/zhong2006/zhong2006.h"
#include "rt/vec.h"

static const double static_s = 250.0, static_step_s = 0.05; /* 25 relaxation times of ks/gamma */

/* ---- the body ---- */

static void make_points(ss_tube *tube, bool is_one_way)
{
    int32_t count = 0;
    for (int32_t i = 0; i < SS_TUBE_ROWS; ++i) {
        for (int32_t j = 0; j < SS_TUBE_COLUMNS; ++j) {
            const double angle = 2.0 * SS_PI * j / SS_TUBE_COLUMNS;
            ss_set3(tube->position[i * SS_TUBE_COLUMNS + j], sin(angle), cos(angle),
                    4.0 * ((double)i / (SS_TUBE_ROWS - 1) - 0.5));
        }
    }
    for (int32_t i = 0; i + 1 < SS_TUBE_ROWS; ++i) {
        for (int32_t j = 0; j < SS_TUBE_COLUMNS; ++j) {
            const int32_t a = i * SS_TUBE_COLUMNS + j;
            const int32_t b = i * SS_TUBE_COLUMNS + (j + 1) % SS_TUBE_COLUMNS;
            const int32_t c = a + SS_TUBE_COLUMNS, d = b + SS_TUBE_COLUMNS;
            const bool is_slash = is_one_way || (i + j) % 2 == 0; /* a to d, else b to c */
            const int32_t half[2][3] = {{b, a, is_slash ? d : c}, {d, is_slash ? a : b, c}};
            memcpy(tube->triangle[count++], half[0], sizeof half[0]);
            memcpy(tube->triangle[count++], half[1], sizeof half[1]);
        }
    }
}

/* The program's number of every point; false when a point has none. */
static bool find_nodes(ss_tube *tube)
{
    double middle[3] = {0.0, 0.0, 0.0};
    for (int32_t n = 0; n < tube->body.node_count; ++n) {
        ss_madd3(middle, middle, 1.0 / tube->body.node_count, tube->body.rest[n]);
    }
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        double nearest = 1e-4;
        tube->node[i] = -1;
        for (int32_t n = 0; n < tube->body.node_count; ++n) {
            double gap[3];
            ss_sub3(gap, tube->body.rest[n], middle);
            ss_sub3(gap, gap, tube->position[i]);
            if (ss_norm3(gap) < nearest) {
                nearest = ss_norm3(gap);
                tube->node[i] = n;
            }
        }
        if (tube->node[i] < 0) {
            return false;
        }
    }
    return tube->body.node_count == SS_TUBE_POINTS;
}

static void write_fixed(ss_tube *tube)
{
    size_t used = (size_t)snprintf(tube->fixed, sizeof tube->fixed, "[{nodes: [");
    for (int32_t j = 0; j < 2 * SS_TUBE_COLUMNS; ++j) {
        const int32_t point = j < SS_TUBE_COLUMNS ? j : SS_TUBE_POINTS - 2 * SS_TUBE_COLUMNS + j;
        used += (size_t)snprintf(tube->fixed + used, sizeof tube->fixed - used, "%s%d",
                                 j > 0 ? ", " : "", tube->node[point]);
    }
    snprintf(tube->fixed + used, sizeof tube->fixed - used, "]}]");
}

softsim_status ss_tube_init(const ss_paper *paper, bool is_grid, bool is_one_way, ss_tube *out_tube,
                            softsim_error *error)
{
    const char *file = is_one_way ? "one-way.msh" : "tube.msh";
    char object[256];
    softsim_status status = SOFTSIM_OK;
    *out_tube = (ss_tube){.name = is_grid ? "grid" : "triangles", .is_grid = is_grid};
    make_points(out_tube, is_one_way);
    if (is_grid) {
        snprintf(object, sizeof object,
                 "  grid: {cylinder: {rows: %d, columns: %d, radius_m: 1, length_m: 4}}\n",
                 SS_TUBE_ROWS, SS_TUBE_COLUMNS);
    } else {
        snprintf(object, sizeof object, "  mesh: %s\n  units: m\n", file);
        status =
            ss_trial_write_mesh(paper, file, SS_TUBE_POINTS, (const double(*)[3])out_tube->position,
                                SS_TUBE_TRIANGLES, (const int32_t(*)[3])out_tube->triangle, error);
    }
    if (status == SOFTSIM_OK) {
        status = ss_trial_look(paper, object, &out_tube->body, out_tube->reason, error);
    }
    if (status != SOFTSIM_OK || out_tube->body.node_count == 0) {
        return status;
    }
    out_tube->is_there = find_nodes(out_tube);
    if (!out_tube->is_there) {
        snprintf(out_tube->reason, sizeof out_tube->reason,
                 "the body has %d nodes and they are not where the cylinder's 360 points are",
                 out_tube->body.node_count);
        return SOFTSIM_OK;
    }
    write_fixed(out_tube);
    return SOFTSIM_OK;
}

void ss_tube_fini(ss_tube *tube)
{
    ss_trial_body_fini(&tube->body);
}

/* ---- scenes ---- */

typedef struct text {
    char at[2048];
    size_t used;
} text;

static void add(text *to, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add(text *to, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int count = vsnprintf(to->at + to->used, sizeof to->at - to->used, format, arguments);
    va_end(arguments);
    to->used += count > 0 ? (size_t)count : 0;
    to->used = to->used < sizeof to->at ? to->used : sizeof to->at - 1;
}

static softsim_status write_rho(const ss_paper *paper, const ss_tube *tube, const double *rho,
                                softsim_error *error)
{
    double value[SS_TUBE_POINTS];
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        value[tube->node[i]] = rho[i];
    }
    return ss_trial_write_field(paper, "rho.csv", SS_TUBE_POINTS, value, error);
}

static void write_model(const ss_tube_setup *setup, text *model)
{
    add(model, "  name: cnn-energy\n  modulus_n_per_m: %.17g\n", SS_TUBE_MODULUS);
    if (setup->across > 0.0) {
        add(model, "  rho_direction: %.17g\n  rho_across: %.17g\n  material_direction: [0, 0, 1]\n",
            setup->rho_along, setup->rho_along * setup->across);
    } else if (setup->rho != NULL) {
        add(model, "  rho: {file: rho.csv}\n");
    } else {
        add(model, "  rho: %.17g\n", SS_TUBE_RHO);
    }
    if (setup->is_per_area) {
        add(model,
            "  area_density_kg_m2: %.17g\n  damping_n_s_per_m3: %.17g\n"
            "  rest_stiffness_n_per_m3: %.17g\n",
            1.0 / setup->mean_area, setup->gamma / setup->mean_area, SS_TUBE_KS / setup->mean_area);
    } else {
        add(model,
            "  per_area: false\n  mass_kg: 1\n  damping_n_s_per_m: %.17g\n"
            "  rest_stiffness_n_per_m: %.17g\n",
            setup->gamma, SS_TUBE_KS);
    }
    if (setup->saturation > 0.0) {
        add(model, "  saturation: %.17g\n", setup->saturation);
    }
    if (setup->relaxation_steps > 0) {
        add(model, "  solver: relaxation\n  relaxation_steps: %d\n", setup->relaxation_steps);
    }
}

static void write_loads(const ss_tube *tube, const ss_tube_setup *setup, text *loads)
{
    add(loads, "loads:\n");
    for (int32_t k = 0; k < setup->load_count; ++k) {
        const ss_tube_load *load = &setup->load[k];
        add(loads, "  - {nodes: [");
        const int32_t half = load->count / 2;
        for (int32_t row = -half; row <= half; ++row) {
            add(loads, "%s%d", row > -half ? ", " : "",
                tube->node[load->point + row * SS_TUBE_COLUMNS]);
        }
        add(loads, "], force_n: [0, %.17g, 0], from_s: %.17g, ramp_s: %.17g}\n", -load->force,
            load->from, load->ramp);
    }
}

softsim_status ss_tube_begin(const ss_paper *paper, const ss_tube *tube, const ss_tube_setup *setup,
                             ss_trial *out_trial, softsim_error *error)
{
    text model = {.used = 0}, loads = {.used = 0};
    softsim_status status = SOFTSIM_OK;
    if (setup->rho != NULL) {
        status = write_rho(paper, tube, setup->rho, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    write_model(setup, &model);
    write_loads(tube, setup, &loads);
    const ss_trial_plan plan = {.body = &tube->body,
                                .fixed = tube->fixed,
                                .model = model.at,
                                .rest = loads.at,
                                .step_s = setup->step_s};
    return ss_trial_begin(paper, &plan, out_trial, error);
}

double ss_tube_depth(const ss_tube *tube, const ss_trial *trial)
{
    return -trial->u[tube->node[SS_TUBE_CONTACT]][1];
}

double ss_tube_width(const ss_tube *tube, const ss_trial *trial)
{
    return 2.0 + trial->u[tube->node[SS_TUBE_LEFT]][0] - trial->u[tube->node[SS_TUBE_RIGHT]][0];
}

void ss_tube_points(const ss_tube *tube, const ss_trial *trial, double (*out_u)[3])
{
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        ss_copy3(out_u[i], trial->u[tube->node[i]]);
    }
}

softsim_status ss_tube_static(ss_paper *paper, const ss_tube *tube, const ss_tube_setup *setup,
                              const char *what, double *out_depth, double *out_width,
                              double (*out_u)[3], softsim_error *error)
{
    ss_trial trial;
    ss_tube_setup still = *setup;
    *out_depth = *out_width = (double)NAN;
    if (!tube->is_there) {
        return SOFTSIM_OK;
    }
    still.gamma = setup->gamma > 0.0 ? setup->gamma : 1.0;
    still.step_s = static_step_s;
    softsim_status status = ss_tube_begin(paper, tube, &still, &trial, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (trial.world == NULL) {
        ss_paper_miss(paper, trial.reason, "%s (%s)", what, tube->name);
        return SOFTSIM_OK;
    }
    status = ss_trial_run(&trial, (int32_t)(static_s * still.gamma / static_step_s), error);
    *out_depth = ss_tube_depth(tube, &trial);
    *out_width = ss_tube_width(tube, &trial);
    if (out_u != NULL) {
        ss_tube_points(tube, &trial, out_u);
    }
    ss_trial_end(&trial);
    return status;
}

/* ---- the report's reference network ---- */

ss_zhong_net *ss_tube_net(const ss_tube *tube, const double *rho, double across)
{
    static const double axis[3] = {0.0, 0.0, 1.0};
    ss_zhong_net *net =
        tube->is_grid
            ? ss_zhong_net_tube(SS_TUBE_ROWS, SS_TUBE_COLUMNS, (const double(*)[3])tube->position,
                                across > 0.0 ? across : 1.0)
            : ss_zhong_net_triangles(SS_TUBE_POINTS, (const double(*)[3])tube->position,
                                     SS_TUBE_TRIANGLES, (const int32_t(*)[3])tube->triangle,
                                     across > 0.0 ? axis : NULL, across);
    for (int32_t i = 0; net != NULL && i < SS_TUBE_POINTS; ++i) {
        net->is_held[i] = i < SS_TUBE_COLUMNS || i >= SS_TUBE_POINTS - SS_TUBE_COLUMNS;
        net->rho[i] = rho != NULL ? rho[i] : SS_TUBE_RHO;
    }
    if (net != NULL) {
        net->is_source[SS_TUBE_CONTACT] = 1;
        if (!ss_zhong_net_solve(net)) {
            ss_zhong_net_destroy(&net);
        }
    }
    return net;
}

double ss_tube_net_static(ss_zhong_net *net, double force, const double *stiffness,
                          double *out_width)
{
    static double pushed[SS_TUBE_POINTS][3], u[SS_TUBE_POINTS][3];
    double ks[SS_TUBE_POINTS];
    for (int32_t i = 0; i < SS_TUBE_POINTS; ++i) {
        ks[i] = stiffness != NULL ? stiffness[i] : SS_TUBE_KS;
    }
    pushed[SS_TUBE_CONTACT][1] = -force;
    const double current =
        ss_zhong_net_static(net, SS_TUBE_MODULUS, ks, (const double(*)[3])pushed, u);
    if (out_width != NULL) {
        *out_width = 2.0 + u[SS_TUBE_LEFT][0] - u[SS_TUBE_RIGHT][0];
    }
    return isnan(current) ? current : -u[SS_TUBE_CONTACT][1];
}
