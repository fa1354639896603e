/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench accuracy with a damaged case among whole ones: whatever is wrong, with whichever
 * file, the call names it, runs nothing, leaves no report and ends with 2. And with whole ones: a
 * field that has little to do with the reference is told in words, a swing is judged by all its
 * steps, and what was run before a case was mended is not resumed.
 */
#include "common/test.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "accuracy_fixture.h"
#include "bench/accuracy/accuracy.h"
#include "case/table.h"
#include "common/effort.h"
#include "models/model.h"

static const char statement[] =
    "material: {youngs_modulus_pa: 1e4, poisson_ratio: 0.3}\nfixed: fixed\n"
    "prescribed: {set: patch, direction: [0, 0, -1]}\nlevels: {linear: {a: 0.001}}\n"
    "meshes: {m: {volume: m.msh, sets: s.json, reference: {linear: r.csv}}}\nforce: f.csv\n";

/* A case `name` of one tetrahedron in `part` of the folder. */
static void write_tiny(const char *part, const char *name)
{
    char text[1024];
    snprintf(text, sizeof text, "case: %s\n%s", name, statement);
    assert_true(mkdir(in_folder(part), 0777) == 0 || errno == EEXIST);
    const struct {
        const char *name, *text;
    } file[] = {{"case.yaml", text},
                {"m.msh", good_mesh},
                {"s.json", good_sets},
                {"r.csv", good_reference},
                {"f.csv", "material,depth_m,Fx_N,Fy_N,Fz_N\nlinear,0.001,0,0,-1\n"}};
    for (size_t k = 0; k < sizeof file / sizeof *file; ++k) {
        char relative[64];
        snprintf(relative, sizeof relative, "%s/%s", part, file[k].name);
        write_text(relative, file[k].text);
    }
}

/* What a run says on stderr; to be freed. */
static char *run_heard(const char *const *option, int *out_result)
{
    size_t size = 0;
    softsim_error error = {.status = SOFTSIM_OK};
    *out_result = run_accuracy(option, stderr, in_folder("heard.txt"));
    return ss_table_read_file(in_folder("heard.txt"), &size, &error);
}

static int run(const char *const *option)
{
    int result = 0;
    free(run_heard(option, &result));
    return result;
}

/* Whatever is wrong with the last case of a call, none is run, and the file is named. */
TEST(a_damaged_case_stops_the_call_before_any_run)
{
    static const struct {
        const char *name, *text; /* NULL: not there */
        const char *says;
    } bad[] = {
        {"case.yaml", NULL, "damaged/case.yaml: No such file"},
        {"case.yaml", "case: [", "damaged/case.yaml:1:"},
        {"m.msh", NULL, "damaged/m.msh: No such file"},
        {"m.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n7 0 0 0\n", "damaged/m.msh:"},
        {"s.json", NULL, "damaged/s.json: No such file"},
        {"r.csv", NULL, "damaged/r.csv: No such file"},
        {"r.csv",
         "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,.1,0,0,inf\n3,1,0,0,.1,0,0,0\n7,0,0,0,.1,0,0,0\n9,0,"
         "1,0,.1,0,0,0\n",
         "damaged/r.csv:2: column"},
        {"r.csv", "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,.1,0,0,1e-3\n", "damaged/r.csv: only 1 of"},
        {"f.csv", "material,depth_m,Fx_N,Fy_N,Fz_N\nlinear,0.001,0,0\n", "damaged/f.csv:2: column"},
        {"f.csv", "material,depth_m,Fx_N,Fy_N,Fz_N\n", "damaged/f.csv: no row for linear"},
    };
    const char *whole = in_folder("whole"), *damaged = in_folder("damaged");
    const char *out = in_folder("no-report"), *none = in_folder("none.csv");
    if (ss_model_find("fem") == NULL) {
        skip();
    }
    write_tiny("whole", "whole");
    for (size_t i = 0; i <= sizeof bad / sizeof *bad; ++i) {
        const bool is_compared = i == sizeof bad / sizeof *bad;
        const char *says = is_compared ? "none.csv: No such file" : bad[i].says;
        int result = 0;
        write_tiny("damaged", "damaged");
        if (!is_compared) {
            char relative[64];
            snprintf(relative, sizeof relative, "damaged/%s", bad[i].name);
            const char *file = write_text(relative, bad[i].text != NULL ? bad[i].text : "");
            assert_true(bad[i].text != NULL || unlink(file) == 0);
        }
        char *text = run_heard((const char *const[]){"--case", whole, "--case", damaged, "--model",
                                                     "fem", "--out", out,
                                                     is_compared ? "--compare" : NULL, none, NULL},
                               &result);
        assert_int_equal(result, 2);
        assert_non_null(text);
        if (strstr(text, says) == NULL || strstr(text, "nothing was run") == NULL) {
            fail_msg("damage %d: no '%s' in: %s", (int)i, says, text);
        }
        free(text);
        assert_int_not_equal(access(out, F_OK), 0);
    }
}

/* The node that is pushed is right; in the other reference a held one has gone as far. */
TEST(a_poor_field_is_said_in_the_verdict)
{
    static const char *const reference[] = {
        good_reference, "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,.1,0,0,-.001\n3,1,0,0,.1,0,.001,0\n"
                        "7,0,0,0,.1,0,0,0\n9,0,1,0,.1,0,0,0\n"};
    if (ss_model_find("fem") == NULL) {
        skip();
    }
    for (int k = 0; k < 2; ++k) {
        const char *out = in_folder(k == 0 ? "right" : "wrong");
        int result = 0;
        size_t size = 0;
        softsim_error error = {.status = SOFTSIM_OK};
        write_tiny("judged", "judged");
        write_text("judged/r.csv", reference[k]);
        free(run_heard((const char *const[]){"--case", in_folder("judged"), "--model", "fem",
                                             "--quick", "--out", out, NULL},
                       &result));
        assert_int_equal(result, 0);
        char *text = ss_table_read_file(
            in_folder(k == 0 ? "right/accuracy.csv" : "wrong/accuracy.csv"), &size, &error);
        assert_non_null(text);
        assert_true((strstr(text, "poor field: half of it or more is wrong") != NULL) == (k == 1));
        assert_non_null(strstr(text, "good"));
        free(text);
    }
}

/* The coarsest bundled beam, dropped twice, with a first frequency of `hz` for a reference. */
static void swing_beam(double hz, char out_verdict[512], double *out_f1_error)
{
    char text[2048];
    ss_table table;
    softsim_error error = {.status = SOFTSIM_OK};
    snprintf(text, sizeof text,
             "case: beam\nkind: dynamic\nmaterial: {youngs_modulus_pa: 50000, poisson_ratio: 0.3, "
             "density_kg_m3: 1000}\nfixed: fixed\nprobe_point_m: [0.1, 0, 0]\nmodes: {file: "
             "modes.csv, model: x, column: f}\nmeshes: {\"99\": {volume: " REFERENCE
             "/b_cantilever/mesh_99.msh, sets: " REFERENCE "/b_cantilever/nodesets_99.json}}\n"
             "steps:\n"
             "  - {gravity_m_s2: [0, 0, -0.2], reference: drop.csv, compare_until_s: 0.007}\n"
             "  - {gravity_m_s2: [0, 0, -0.4], reference: drop.csv, compare_until_s: 0.007}\n");
    write_text("case.yaml", text);
    snprintf(text, sizeof text, "model,f\nx,%g\n", hz);
    write_text("modes.csv", text);
    size_t used = (size_t)snprintf(text, sizeof text, "t_s,tip_ux_m,tip_uy_m,tip_uz_m\n");
    for (int i = 0; i < 8; ++i) {
        used += (size_t)snprintf(text + used, sizeof text - used, "%g,0,0,%g\n", 1e-3 * i,
                                 -1e-7 * i * i);
    }
    write_text("drop.csv", text);
    assert_int_equal(run((const char *const[]){"--case", folder, "--model", "fem", "--out",
                                               in_folder("swing"), NULL}),
                     0);
    assert_int_equal(ss_table_load(in_folder("swing/dynamics.csv"), &table, &error), SOFTSIM_OK);
    assert_int_equal(table.row_count, 1);
    const int32_t verdict = ss_table_find(&table, "verdict", &error);
    const int32_t f1 = ss_table_find(&table, "f1_error", &error);
    snprintf(out_verdict, 512, "%s", ss_table_cell(&table, 0, verdict));
    *out_f1_error = *ss_table_cell(&table, 0, f1) != '\0' ? ss_table_number(&table, 0, f1, &error)
                                                          : (double)NAN;
    ss_table_fini(&table);
}

TEST(a_swing_is_judged_by_all_its_steps)
{
    SKIP_WHERE_REPEATED();
    char verdict[512];
    double error;
    if (ss_model_find("fem") == NULL) {
        skip();
    }
    /* Linear tetrahedra of this mesh: modes.csv of g_dynamics. */
    swing_beam(1.0, verdict, &error);
    assert_true(fabs(error - 1.82577) < 0.01);
    assert_non_null(strstr(verdict, "at 0.2 m/s^2"));
    assert_non_null(strstr(verdict, "at 0.4 m/s^2"));
    /* Nothing can be said of what is faster than the steps. */
    swing_beam(5000.0, verdict, &error);
    assert_true(isnan(error));
    assert_non_null(strstr(verdict, "5e+03 Hz"));
}

/* A row that no picture can show as what it is stops the call before any run. */
TEST(an_odd_row_of_another_program_is_refused)
{
    static const says_row bad[] = {
        {"tiny,linear,theirs,m,4,1,a,0.1,0.1,0.1,5", "odd.csv:3: 11 cells, the head line has 17"},
        {"tiny,linear,theirs,m,4,1,a,-0.1,,,5,,,,,no,good", "odd.csv:3: error_l2"},
        {"tiny,linear,theirs,m,4,1,a,0.1,,-2,5,,,,,no,good", "odd.csv:3: error_force"},
        {"tiny,linear,theirs,m,4,1,a,0.1,,,0,,,,,no,good", "odd.csv:3: us_per_step_p50"},
        {"tiny,linear,theirs,m,4,1,a,0.1,,,5,,1e308,,,no,good", "odd.csv:3: realtime_factor"},
        {"tiny,linear,theirs,m,4,1,a,inf,,,5,,,,,no,good", "odd.csv:3: column 'error_l2'"},
        {"tiny,linear,theirs,m,-4,1,a,0.1,,,5,,,,,no,good", "odd.csv:3: column 'nodes'"},
        {"tiny,linear,theirs,m,4.5,1,a,0.1,,,5,,,,,no,good", "odd.csv:3: column 'nodes'"},
        {"tiny,linear,theirs,m,4,1,a,0.1,,,5,,,,,no,fine", "odd.csv:3: verdict 'fine'"},
        {"tiny,linear,theirs,m,4,1,a,0.1,,,5,,,,,no,goodish", "odd.csv:3: verdict 'goodish'"},
        {"tiny,linear,theirs,m,4,1,a,0.1,,,5,,,,,maybe,good", "odd.csv:3: calibrated is 'maybe'"},
        {"tiny,linear,theirs,m,4,1,b,0.1,,,5,,,,,no,good", "odd.csv:3: case 'tiny' has no level"},
        {"tiny,nh,theirs,m,4,1,a,0.1,,,5,,,,,no,good", "odd.csv:3: case 'tiny' has no level"},
        {"other,linear,theirs,m,4,1,a,0.1,,,5,,,,,no,good", "odd.csv:3: case 'other'"},
        {"tiny,linear,mass-spring,m,4,1,a,0.1,,,5,,,,,no,good", "odd.csv:3: model 'mass-spring'"},
        {"tiny,linear,,m,4,1,a,0.1,,,5,,,,,no,good", "odd.csv:3: model is empty"},
    };
    const char *out = in_folder("odd"), *tiny = in_folder("tiny");
    char text[1024];
    if (ss_model_find("mass-spring") == NULL) {
        skip();
    }
    write_tiny("tiny", "tiny");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        int result = 0;
        snprintf(text, sizeof text, "%s\ntiny,linear,theirs,m,4,1,a,0.1,,,5,,,,,no,\n%s\n",
                 ss_accuracy_head, bad[i].given);
        const char *other = write_text("odd.csv", text);
        char *heard = run_heard((const char *const[]){"--case", tiny, "--model", "mass-spring",
                                                      "--compare", other, "--out", out, NULL},
                                &result);
        assert_non_null(heard);
        if (result != 2 || strstr(heard, bad[i].says) == NULL ||
            strstr(heard, "odd.csv:3") != strstr(heard, "odd.csv:") ||
            strstr(heard, "nothing was run") == NULL) {
            fail_msg("row '%s': status %d, no '%s' in: %s", bad[i].given, result, bad[i].says,
                     heard);
        }
        free(heard);
        assert_int_not_equal(access(out, F_OK), 0);
    }
}

/* A scene's reference takes minutes: rows are judged before it is made, and a scene that is no case
 * leaves no folder behind. */
TEST(a_scene_that_cannot_be_run_leaves_nothing)
{
    char text[1024];
    if (ss_model_find("fem") == NULL) {
        skip();
    }
    const char *scene =
        write_text("scene.yaml",
                   "softsim: 1\nobject: {mesh: " REFERENCE "/b_cantilever/mesh_99.msh, units: m, "
                   "fixed: [{box_m: [[-1, -1, -1], [1e-6, 1, 1]]}]}\nmodel: {name: fem, "
                   "youngs_modulus_pa: 1e4, poisson_ratio: 0.3, density_kg_m3: 1000}\n");
    snprintf(text, sizeof text, "%s\nscene,stvk,theirs,m,4,1,whole,0.1,,,5,,,,,no,\n",
             ss_accuracy_head);
    const char *other = write_text("odd.csv", text);
    const char *out = in_folder("left"), *deeper = in_folder("left/deeper");
    for (int k = 0; k < 2; ++k) {
        int result = 0;
        char *heard = run_heard((const char *const[]){"--scene", scene, "--out", deeper,
                                                      k == 0 ? "--compare" : NULL, other, NULL},
                                &result);
        assert_int_equal(result, 2);
        assert_non_null(heard);
        assert_true((strstr(heard, "odd.csv:2: case 'scene' has no level 'whole'") != NULL) ==
                    (k == 0));
        assert_true((strstr(heard, "exactly one of") != NULL) == (k == 1));
        free(heard);
        assert_int_not_equal(access(out, F_OK), 0);
    }
}

/* Rows of another program may be more than all of our models and meshes. */
TEST(every_row_of_another_program_is_on_the_page)
{
    enum { ROWS = 300 };
    char last[32];
    size_t size = 0;
    softsim_error error = {.status = SOFTSIM_OK};
    if (ss_model_find("mass-spring") == NULL) {
        skip();
    }
    write_tiny("tiny", "tiny");
    FILE *file = open_file("many.csv");
    fprintf(file, "%s\n", ss_accuracy_head);
    for (int k = 0; k < ROWS; ++k) {
        fprintf(file, "tiny,linear,theirs,m%d,4,1,a,%g,0.1,0.1,%d,9,0.001,9,9,no,good\n", k,
                1.0 / (k + 2), k + 1);
    }
    assert_int_equal(fclose(file), 0);
    assert_int_equal(run((const char *const[]){"--case", in_folder("tiny"), "--model",
                                               "mass-spring", "--compare", in_folder("many.csv"),
                                               "--out", in_folder("many"), NULL}),
                     0);
    snprintf(last, sizeof last, ">m%d<", ROWS - 1);
    char *text = ss_table_read_file(in_folder("many/accuracy.html"), &size, &error);
    assert_non_null(text);
    assert_non_null(strstr(text, ">m0<"));
    assert_non_null(strstr(text, last));
    free(text);
}

/* What was run before a case was mended is not taken for a result of the mended one. */
TEST(a_mended_case_is_not_resumed)
{
    if (ss_model_find("mass-spring") == NULL) {
        skip();
    }
    const char *out = in_folder("mended"), *csv = in_folder("mended/accuracy.csv");
    const char *part = in_folder("mended/accuracy.0.part"), *tiny = in_folder("tiny");
    const char *const command[] = {"--case", tiny, "--model", "mass-spring", "--out", out, NULL};
    write_tiny("tiny", "tiny");
    assert_int_equal(mkdir(out, 0777), 0);
    assert_int_equal(mkdir(csv, 0777), 0); /* in the report's way, which is not written */
    assert_int_equal(run(command), 1);
    assert_int_equal(access(part, F_OK), 0);
    assert_int_equal(rmdir(csv), 0);
    write_text("tiny/r.csv", "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,.1,0,0,-.002\n3,1,0,0,.1,0,0,0\n"
                             "7,0,0,0,.1,0,0,0\n9,0,1,0,.1,0,0,0\n");
    assert_int_equal(run(command), 1);
    assert_int_not_equal(access(csv, F_OK), 0);
    write_tiny("tiny", "tiny"); /* as it was: the run goes on */
    assert_int_equal(run(command), 0);
    assert_int_equal(access(csv, F_OK), 0);
    assert_int_not_equal(access(part, F_OK), 0);
}

/* A case's own constants, a key that no model has, no value: none can be set. */
TEST(only_what_is_left_to_choose_can_be_set)
{
    static const char *const odd[] = {"youngs_modulus_pa=1", "lame_mu_pa=1", "depth=1",
                                      "layer.spacing_m=1",   "name=xpbd",    "locking_cure",
                                      "locking_cure=",       "=1",           ""};
    if (ss_model_find("fem") == NULL) {
        skip();
    }
    for (size_t k = 0; k < sizeof odd / sizeof *odd; ++k) {
        int result = 0;
        char *heard =
            run_heard((const char *const[]){"--case", REFERENCE "/c_slab", "--model", "fem",
                                            "--set", odd[k], "--out", in_folder("set"), NULL},
                      &result);
        if (result != 2 || strstr(heard, "--set") == NULL) {
            fail_msg("'%s': %d: %s", odd[k], result, heard);
        }
        free(heard);
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
