/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench scaling, run as people run it on the smallest bodies: every model's row has a time
 * per step, and says by what its linear equations are solved. The field of every row of cnn-energy
 * is that of a direct solve, and the direct solve is worth comparing with: where the answer is
 * known in closed form it finds it, from anywhere, and what is wrong in it shows.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/core/static_cnn.h"
#include "bench/scaling/body.h"
#include "bench/stability/stress_case.h"
#include "case/table.h"
#include "common/effort.h"
#include "rt/vec.h"

#include "common/folder_fixture.h"

/* What a field may be off, of the largest displacement. */
#define FIELD_TOLERANCE 1e-5

static const char *cell(const ss_table *table, int32_t row, const char *name)
{
    softsim_error error = {.status = SOFTSIM_OK};
    const int32_t column = ss_table_find(table, name, &error);
    assert_true(column >= 0);
    return ss_table_cell(table, row, column);
}

static bool begins(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

TEST(every_row_has_a_time_and_names_its_solver)
{
    SKIP_WHERE_REPEATED();
    char command[512], path[128];
    ss_table table;
    softsim_error error = {.status = SOFTSIM_OK};
    int32_t blocks = 0;
    snprintf(command, sizeof command,
             BIN_DIR "/softsim-bench scaling --points 300 --out %s/report > %s/out 2>&1", folder,
             folder);
    assert_int_equal(system(command), 0);
    snprintf(path, sizeof path, "%s/report/scaling.csv", folder);
    assert_int_equal(ss_table_load(path, &table, &error), SOFTSIM_OK);
    for (int32_t i = 0; i < table.row_count; ++i) {
        const bool is_block = strcmp(cell(&table, i, "case"), "block") == 0;
        const char *model = cell(&table, i, "model"), *solver = cell(&table, i, "solver");
        const char *time = cell(&table, i, "step_us_p50");
        const char *apart = cell(&table, i, "field_error_direct");
        if (!(strtod(time, NULL) > 0.0) || begins(cell(&table, i, "verdict"), "refused")) {
            fail_msg("%s: '%s' us: %s", model, time, cell(&table, i, "verdict"));
        }
        if (is_block) {
            assert_string_equal(apart, "");
        } else if (!(strtod(apart, NULL) > 0.0 && strtod(apart, NULL) < FIELD_TOLERANCE)) {
            fail_msg("%s: '%s' off a direct solve", cell(&table, i, "case"), apart);
        }
        if (is_block && begins(model, "cnn-energy")) {
            assert_true(begins(solver, "a factor of "));
        } else if (is_block && begins(model, "corotational")) {
            assert_true(begins(solver, "conjugate gradients"));
        }
        blocks += is_block;
    }
    assert_int_equal(blocks, ss_stress_case_subject_count());
    ss_table_fini(&table);
}

/* ---- fields ---- */

static void assert_exact(const char *what, const ss_body_run *run)
{
    if (run->is_refused || !(run->direct_error > 0.0 && run->direct_error < FIELD_TOLERANCE)) {
        fail_msg("%s: off by %g %s", what, run->direct_error, run->reason);
    }
}

static double highest(const ss_body_run *run)
{
    double length = 0.0;
    for (int32_t i = 0; i < run->nodes; ++i) {
        length = fmax(length, ss_norm3(run->displacement[i]));
    }
    return length;
}

TEST(fields_are_those_of_a_direct_solve)
{
    SKIP_WHERE_REPEATED();
    ss_body body;
    ss_body_run load, all, part, pull;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_body_open(&body, &error), SOFTSIM_OK);
    snprintf(body.bin, sizeof body.bin, "%s", BIN_DIR);
    assert_int_equal(ss_body_make(&body, 4100, &error), SOFTSIM_OK); /* has a window */
    assert_int_equal(ss_body_load(&body, &load, &error), SOFTSIM_OK);
    assert_int_equal(ss_body_poke(&body, true, &all, &error), SOFTSIM_OK);
    assert_int_equal(ss_body_poke(&body, false, &part, &error), SOFTSIM_OK);
    assert_int_equal(ss_body_pull(&body, &pull, &error), SOFTSIM_OK);
    assert_exact("load", &load);
    assert_exact("poke with all nodes active", &all);
    assert_exact("pull", &pull);
    assert_true(part.active_nodes < part.nodes);
    assert_true(part.direct_error > 10.0 * all.direct_error); /* what the window leaves out, */
    assert_true(fabs(part.direct_error - ss_body_apart(&part, &all)) < FIELD_TOLERANCE);
    assert_true(highest(&pull) < 4.0 * highest(&all)); /* five times the force: modulus acts */
    ss_body_run_fini(&pull);
    ss_body_run_fini(&load);
    ss_body_run_fini(&all);
    ss_body_run_fini(&part);
    ss_body_close(&body);
}

/* A direct solve that fails leaves its reason, and the run as it was. */
TEST(a_missing_direct_solve_is_told)
{
    ss_body body;
    ss_body_run run;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_body_open(&body, &error), SOFTSIM_OK);
    snprintf(body.bin, sizeof body.bin, "%s", BIN_DIR);
    assert_int_equal(ss_body_make(&body, 300, &error), SOFTSIM_OK);
    assert_int_equal(ss_body_load(&body, &run, &error), SOFTSIM_OK);
    ss_body_run_fini(&run);
    for (int32_t i = 0; i < body.node_count; ++i) {
        body.rest[i][2] += 1.0; /* for the direct solve nothing is held */
    }
    assert_int_equal(ss_body_poke(&body, true, &run, &error), SOFTSIM_OK);
    assert_true(isnan(run.direct_error) && ss_samples_quantile(&run.tick_us, 0.5) > 0.0);
    assert_non_null(strstr(run.direct_reason, "not held"));
    ss_body_run_fini(&run);
    ss_body_close(&body);
}

/* ---- the direct solve ---- */

/* A hexagon of edge h held at its corners, its centre pushed out of the plane: by symmetry
 * ks z + T0 z / h^2 + E^ z^3 / (2 h^4) = F. */
enum { RIM = 6 };
typedef struct fan {
    double rest[RIM + 1][3], force[RIM + 1][3], weight[RIM + 1];
    int32_t triangle[RIM][3];
    uint8_t is_held[RIM + 1];
    ss_static_cnn_problem problem;
} fan;
static const double fan_edge = 0.1, fan_force = 0.3, fan_modulus = 2.0, fan_pretension = 0.01,
                    fan_rest = 1e3;

static void make_fan(fan *f)
{
    *f = (fan){.weight = {1.0}, .force = {{0.0, 0.0, fan_force}}};
    for (int k = 0; k < RIM; ++k) {
        const double angle = 2.0 * SS_PI * k / RIM;
        f->rest[k + 1][0] = fan_edge * cos(angle);
        f->rest[k + 1][1] = fan_edge * sin(angle);
        f->is_held[k + 1] = 1;
        f->triangle[k][1] = 1 + k;
        f->triangle[k][2] = 1 + (k + 1) % RIM;
    }
    f->problem = (ss_static_cnn_problem){.node_count = RIM + 1,
                                         .triangle_count = RIM,
                                         .rest = (const double(*)[3])f->rest,
                                         .triangle = (const int32_t(*)[3])f->triangle,
                                         .modulus = fan_modulus,
                                         .pretension = fan_pretension,
                                         .rest_stiffness = fan_rest,
                                         .is_held = f->is_held,
                                         .weight = f->weight,
                                         .force = (const double(*)[3])f->force};
}

/* How high the centre comes, from a field where all nodes are at `start`. */
static double fan_height(const fan *f, double start)
{
    double u[RIM + 1][3];
    for (int i = 0; i <= RIM; ++i) {
        ss_set3(u[i], 0.0, 0.0, start);
    }
    softsim_error error = {.status = SOFTSIM_OK};
    if (ss_static_cnn_solve(&f->problem, u, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return u[0][2];
}

TEST(a_direct_solve_finds_the_known_answer)
{
    fan f;
    make_fan(&f);
    const double square = fan_edge * fan_edge;
    const double ks = fan_rest * 0.5 * sqrt(3.0) * square;
    double z = 0.0;
    for (double size = 1.0; size > 1e-17; size *= 0.5) { /* the least place, from below */
        const double at = z + size;
        const double pull = ks * at + fan_pretension * at / square +
                            fan_modulus * at * at * at / (2.0 * square * square);
        z = pull < fan_force ? at : z;
    }
    const double start[] = {0.0, z, 1.001 * z, 20.0 * z};
    for (int k = 0; k < 4; ++k) {
        assert_true(fabs(fan_height(&f, start[k]) - z) < 1e-9 * z);
    }

    /* What is wrong in it shows: the modulus, a conductance, the tension, the load. */
    f.problem.modulus *= 1.001;
    assert_true(fabs(fan_height(&f, z) - z) > FIELD_TOLERANCE * z);
    make_fan(&f);
    f.rest[1][0] *= 1.01;
    assert_true(fabs(fan_height(&f, z) - z) > FIELD_TOLERANCE * z);
    make_fan(&f);
    f.problem.pretension *= 1.01;
    assert_true(fabs(fan_height(&f, z) - z) > FIELD_TOLERANCE * z);
    make_fan(&f);
    f.force[0][2] *= 1.001;
    assert_true(fabs(fan_height(&f, z) - z) > FIELD_TOLERANCE * z);
}

TEST(a_direct_solve_says_what_it_cannot_do)
{
    fan f;
    make_fan(&f);
    double u[RIM + 1][3] = {{0.0}};
    softsim_error error = {.status = SOFTSIM_OK};
    memset(f.is_held, 0, sizeof f.is_held);
    assert_int_equal(ss_static_cnn_solve(&f.problem, u, &error), SOFTSIM_ERROR_MESH);
    assert_non_null(strstr(error.text, "not held"));
    error = (softsim_error){.status = SOFTSIM_OK};
    make_fan(&f);
    f.force[0][2] = (double)NAN;
    assert_int_equal(ss_static_cnn_solve(&f.problem, u, &error), SOFTSIM_ERROR_SYSTEM);
    assert_non_null(strstr(error.text, "no equilibrium"));
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
