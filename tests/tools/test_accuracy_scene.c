/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench accuracy --scene: the reference that a scene makes of itself is near the trusted
 * one, is worth what it says, and is refused where fem has none or ends degraded.
 */
#include "common/test.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "accuracy_fixture.h"
#include "bench/accuracy/scene.h"
#include "case/case.h"
#include "case/norms.h"
#include "common/effort.h"
#include "models/model.h"

#define BEAM "name: fem, youngs_modulus_pa: 50000, poisson_ratio: 0.3, density_kg_m3: 1000"
static const char end[] = "[1e-6, 1, 1]"; /* holds the beam's */

/* The reference that a beam of 99 nodes makes of itself, in the folder `made`: held in the box from
 * (-1, -1, -1) to `corner`, of `model`, with `rest` of a scene. */
static softsim_status refer(const char *corner, const char *model, const char *rest,
                            ss_accuracy_worth *out_worth, softsim_error *error)
{
    char text[1024];
    const char *made = in_folder("made");
    snprintf(text, sizeof text,
             "softsim: 1\nobject: {mesh: " REFERENCE "/b_cantilever/mesh_99.msh, units: m, "
             "fixed: [{box_m: [[-1, -1, -1], %s]}]}\nmodel: {%s}\n%s",
             corner, model, rest);
    assert_true(mkdir(made, 0777) == 0 || errno == EEXIST);
    *error = (softsim_error){.status = SOFTSIM_OK};
    return ss_accuracy_scene(write_text("scene.yaml", text), made, true, out_worth, error);
}

/* A beam of 99 nodes in a scene: the reference made by refinement is nearer to the trusted one than
 * it says it is worth, and far nearer than the beam's own mesh. */
TEST(a_scene_makes_its_own_reference)
{
    ss_accuracy_worth worth;
    ss_case c, trusted;
    ss_case_body body, other;
    softsim_error error;
    if (!FULL_IN_RELEASE(true, false) || ss_model_find("fem") == NULL) {
        skip();
    }
    assert_int_equal(
        refer(end, BEAM ", material: linear", "gravity_m_s2: [0, 0, -9.81]\n", &worth, &error),
        SOFTSIM_OK);
    assert_int_equal(worth.nodes, 3321);
    assert_true(worth.ratio > 1.5 && worth.ratio < 4.5);
    assert_non_null(strstr(worth.taken, "gravity, and of its fem Young's modulus 50000 Pa"));
    assert_non_null(strstr(worth.taken, "not taken: damping"));
    /* Both the correction and what has not settled. */
    assert_true(worth.unsettled > 0.0 && worth.unsettled < 1e-3);
    assert_near(worth.left,
                (worth.change[1] + (worth.ratio + 1.0) * worth.unsettled) / (worth.ratio - 1.0),
                1e-12);
    assert_non_null(strstr(worth.text, "Of the least settled run about"));
    assert_null(strstr(worth.text, "Not all of its runs were good"));
    assert_int_equal(ss_case_load(in_folder("made"), &c, &error), SOFTSIM_OK);
    assert_int_equal(c.mesh_count, 2);
    assert_int_equal(ss_case_load_body(&c, &c.mesh[0], 0, false, &body, &error), SOFTSIM_OK);
    assert_int_equal(ss_case_load(REFERENCE "/b_cantilever", &trusted, &error), SOFTSIM_OK);
    assert_int_equal(ss_case_load_body(&trusted, &trusted.mesh[0], 0, false, &other, &error),
                     SOFTSIM_OK);
    const double apart = ss_norms_apart(99, other.weight, (const double(*)[3])body.reference[1],
                                        (const double(*)[3])other.reference[0]);
    assert_true(apart < worth.left);
    assert_true(apart < 0.05); /* that of its own mesh is 0.38 */
    ss_case_body_fini(&body);
    ss_case_body_fini(&other);
    ss_case_fini(&c);
    ss_case_fini(&trusted);
}

/* A node that is pushed by itself goes in without a force as the mesh is refined: the reference is
 * worth little, and it is not said that all is well. */
TEST(a_scene_without_a_limit_is_called_one)
{
    SKIP_WHERE_REPEATED();
    ss_accuracy_worth worth;
    softsim_error error;
    if (ss_model_find("fem") == NULL) {
        skip();
    }
    if (refer("[1, 1, -0.0099]", BEAM ", material: linear",
              "prescribed: [{nodes: [82], displacement_m: [0, 0, -0.0005]}]\n", &worth,
              &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    assert_near(worth.ratio, 1.5, 0.0); /* the least that is taken */
    assert_non_null(strstr(worth.text, "no limit that these meshes reach"));
    assert_null(strstr(worth.text, "it falls as it should"));
}

/* The beam's end goes nearly to its support: fem settles, with elements turned inside out. */
TEST(a_run_that_ends_degraded_makes_no_reference)
{
    ss_accuracy_worth worth;
    softsim_error error;
    if (ss_model_find("fem") == NULL) {
        skip();
    }
    const softsim_status status = refer(
        end, BEAM ", material: neo-hookean",
        "prescribed: [{box_m: [[0.0999, -1, -1], [1, 1, 1]], displacement_m: [-0.09, 0, 0]}]\n",
        &worth, &error);
    if (status != SOFTSIM_ERROR_SCENE) {
        fail_msg("%d: %s%s", (int)status, error.text, status == SOFTSIM_OK ? worth.text : "");
    }
    assert_non_null(strstr(error.text, "no reference on 99 nodes at the full load: degraded"));
}

TEST(scenes_that_are_no_case_are_refused)
{
    static const struct {
        const char *model, *rest, *says;
    } bad[] = {
        {"name: fem, youngs_modulus_pa: 1e4, poisson_ratio: 0.3, density_kg_m3: 1000", "",
         "exactly one of"},
        {"name: fem, youngs_modulus_pa: 1e4, poisson_ratio: 0.3, density_kg_m3: 1000",
         "loads: [{nodes: [54], force_n: [0, 0, -1]}]\n", "no limit as the mesh is refined"},
        {"name: fem, youngs_modulus_pa: 1e4, poisson_ratio: 0.3, density_kg_m3: 1000",
         "prescribed: [{nodes: [54], displacement_m: [0, 0, -0.01], axes: z}]\n", "all axes"},
        {"name: cnn-energy, modulus_j: 1, area_density_kg_m2: 1, damping_n_s_per_m3: 1, "
         "rest_stiffness_n_per_m3: 1",
         "gravity_m_s2: [0, 0, -1]\n", "youngs_modulus_pa"},
    };
    if (ss_model_find("fem") == NULL || ss_model_find("cnn-energy") == NULL) {
        skip();
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        ss_accuracy_worth worth;
        softsim_error error;
        assert_int_not_equal(refer(end, bad[i].model, bad[i].rest, &worth, &error), SOFTSIM_OK);
        if (strstr(error.text, bad[i].says) == NULL) {
            fail_msg("scene %d: no '%s' in: %s", (int)i, bad[i].says, error.text);
        }
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
