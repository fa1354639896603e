/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench accuracy: norms have the values worked out by hand, tables and case folders are
 * read as they are and refused with their place when they are wrong, the Pareto front and the
 * choice within a budget are the right ones, and a whole run on a small case, pushed and pulled, is
 * calibrated and leaves the rows it should, twice the same.
 */
#include "common/test.h"

#include <dirent.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "accuracy_fixture.h"
#include "bench/accuracy/accuracy.h"
#include "bench/accuracy/refine.h"
#include "case/case.h"
#include "case/norms.h"
#include "case/table.h"
#include "common/effort.h"
#include "models/model.h"

/* ---- norms ---- */

TEST(norms_have_the_values_worked_out_by_hand)
{
    const double weight[] = {1.0, 3.0};
    const double reference[][3] = {{3.0, 0.0, 4.0}, {0.0, 0.0, 2.0}};
    const double u[][3] = {{3.0, 1.0, 4.0}, {0.0, 0.0, 0.0}};
    const ss_norms norms = ss_norms_compute(2, weight, u, reference);
    assert_near(norms.field, sqrt((1.0 + 3.0 * 4.0) / (25.0 + 3.0 * 4.0)), 1e-15);
    assert_near(norms.peak, 2.0 / 5.0, 1e-15);
    const double force[] = {0.0, 7.0, -3.0}, down[] = {0.0, 0.0, -1.0}, up[] = {0.0, 0.0, 1.0};
    assert_near(ss_norms_force(force, down, 2.0), 0.5, 1e-15);
    assert_near(ss_norms_force(force, up, 2.0), 2.5, 1e-15); /* the wrong way round counts */
    assert_near(ss_norms_amplitude(2, weight, reference, reference), 1.0, 1e-15);
    assert_near(ss_norms_amplitude(2, weight, u, reference), 25.0 / 26.0, 1e-15);
}

TEST(norms_without_a_value_are_not_numbers)
{
    const double weight[] = {1.0}, zero[][3] = {{0.0}}, one[][3] = {{1.0, 0.0, 0.0}};
    const double wild[][3] = {{(double)NAN, 0.0, 0.0}}, down[] = {0.0, 0.0, -1.0};
    assert_true(isnan(ss_norms_compute(1, weight, one, zero).field));
    assert_true(isnan(ss_norms_compute(1, weight, one, zero).peak));
    assert_true(isnan(ss_norms_compute(1, weight, wild, one).field));
    assert_true(isnan(ss_norms_compute(1, weight, wild, one).peak));
    assert_true(isnan(ss_norms_force(one[0], down, 0.0)));
    assert_true(isnan(ss_norms_force(one[0], down, (double)NAN)));
}

/* ---- tables ---- */

TEST(tables_keep_quoted_cells_and_short_rows)
{
    ss_table table;
    softsim_error error = {.status = SOFTSIM_OK};
    const char *path = write_text("t.csv", "a,b,c\r\n1,\"x, \"\"y\"\"\",-2e3\r\n\n4\n");
    assert_int_equal(ss_table_load(path, &table, &error), SOFTSIM_OK);
    assert_int_equal(table.column_count, 3);
    assert_int_equal(table.row_count, 2);
    assert_string_equal(ss_table_cell(&table, 0, 1), "x, \"y\"");
    assert_near(ss_table_number(&table, 0, 2, &error), -2000.0, 0.0);
    assert_string_equal(ss_table_cell(&table, 1, 2), "");
    assert_int_equal(error.fault_count, 0);
    assert_true(isnan(ss_table_number(&table, 1, 2, &error)));
    assert_int_equal(ss_table_find(&table, "d", &error), -1);
    assert_int_equal(error.fault_count, 2);
    assert_non_null(strstr(error.text, "t.csv:4: column 'c'"));
    ss_table_fini(&table);
}

TEST(tables_with_too_much_are_refused)
{
    static const char *const bad[] = {"a,b\n1,2,3\n", "a\n1\n2,\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        ss_table table;
        softsim_error error = {.status = SOFTSIM_OK};
        const char *path = write_text("bad.csv", bad[i]);
        assert_int_not_equal(ss_table_load(path, &table, &error), SOFTSIM_OK);
        assert_non_null(strstr(error.text, i == 0 ? "bad.csv:2:" : "bad.csv:3:"));
        ss_table_fini(&table);
    }
}

TEST(damaged_gzip_files_are_refused)
{
    size_t size = 0;
    softsim_error error = {.status = SOFTSIM_OK};
    const char *path = in_folder("x.gz");
    gzFile file = gzopen(path, "wb");
    for (int i = 0; i < 5000; ++i) {
        gzprintf(file, "%d,%d\n", i, i * 7919 % 1000);
    }
    assert_int_equal(gzclose(file), Z_OK);
    char *text = ss_table_read_file(path, &size, &error);
    assert_non_null(text);
    assert_memory_equal(text, "0,0\n1,919\n", 10);
    free(text);
    assert_int_equal(truncate(path, 2000), 0);
    assert_null(ss_table_read_file(path, &size, &error));
    assert_int_equal(error.fault_count, 1);
    assert_null(ss_table_read_file(in_folder("nothing"), &size, &error));
}

/* ---- cases ---- */

TEST(a_good_case_is_read_as_it_is)
{
    ss_case c;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_case_load(REFERENCE "/c_slab", &c, &error), SOFTSIM_OK);
    assert_string_equal(c.name, "c_slab");
    assert_false(c.is_dynamic);
    assert_near(c.youngs_modulus, 1e4, 0.0);
    assert_near(c.poisson_ratio, 0.45, 0.0);
    assert_int_equal(c.material_count, 3);
    assert_int_equal(c.level_count, 8);
    assert_string_equal(c.material[c.level[2].material], "nh");
    assert_string_equal(c.level[2].tag, "5mm");
    assert_near(c.level[2].value, 0.005, 0.0);
    assert_near(c.level[2].force, 2.50034, 1e-12);
    assert_near(c.direction[2], -1.0, 0.0);
    assert_int_equal(c.mesh_count, 3);
    assert_string_equal(c.mesh[1].name, "1k");
    ss_case_fini(&c);
}

/* The volume's weights sum to the slab's volume, the reference is what is prescribed on the patch,
 * and the surface has the same nodes by number, weighted by its own areas. */
TEST(bodies_have_their_nodes_weights_and_references)
{
    ss_case c;
    ss_case_body volume, surface;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_case_load(REFERENCE "/c_slab", &c, &error), SOFTSIM_OK);
    const int32_t nh = 1;
    assert_int_equal(ss_case_load_body(&c, &c.mesh[0], nh, false, &volume, &error), SOFTSIM_OK);
    assert_int_equal(ss_case_load_body(&c, &c.mesh[0], nh, true, &surface, &error), SOFTSIM_OK);
    assert_int_equal(volume.mesh->node_count, 368);
    assert_int_equal(volume.mesh->tetrahedron_count, 1192);
    assert_int_equal(surface.mesh->node_count, 304);
    assert_true(surface.mesh->is_closed);
    double sum = 0.0, area = 0.0;
    for (int32_t i = 0; i < volume.mesh->node_count; ++i) {
        sum += volume.weight[i];
        assert_int_equal(volume.number[i], i + 1);
    }
    for (int32_t i = 0; i < surface.mesh->node_count; ++i) {
        const int32_t other = surface.number[i] - 1;
        area += surface.weight[i];
        assert_memory_equal(surface.mesh->position[i], volume.mesh->position[other],
                            sizeof surface.mesh->position[i]);
        assert_memory_equal(surface.reference[4][i], volume.reference[4][other],
                            sizeof surface.reference[4][i]);
    }
    assert_near(sum, 0.1 * 0.1 * 0.05, 1e-8);
    assert_near(area, 2.0 * 0.1 * 0.1 + 4.0 * 0.1 * 0.05, 1e-8);
    assert_int_equal(volume.pushed_count, 14);
    assert_int_equal(surface.pushed_count, 14);
    assert_int_equal(volume.fixed_count, 90);
    assert_null(volume.reference[0]); /* of another material */
    for (int32_t i = 0; i < volume.pushed_count; ++i) {
        assert_near(volume.reference[4][volume.pushed[i]][2], -0.015 * volume.profile[i], 1e-7);
    }
    ss_case_body_fini(&volume);
    ss_case_body_fini(&surface);
    ss_case_fini(&c);
}

TEST(every_bundled_case_can_be_read)
{
    static const char *const names[] = {"b_cantilever", "e_ventricle", "f_membrane", "g_dynamics"};
    for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
        char path[512];
        ss_case c;
        ss_case_body body;
        softsim_error error = {.status = SOFTSIM_OK};
        snprintf(path, sizeof path, REFERENCE "/%s", names[k]);
        assert_int_equal(ss_case_load(path, &c, &error), SOFTSIM_OK);
        for (int on_surface = 0; on_surface < 2; ++on_surface) {
            int32_t count = 0;
            const ss_case_mesh *mesh = ss_case_meshes(&c, on_surface == 1, &count);
            assert_true(count >= 2);
            assert_int_equal(ss_case_load_body(&c, &mesh[1], c.is_dynamic ? -1 : 0, on_surface == 1,
                                               &body, &error),
                             SOFTSIM_OK);
            ss_case_body_fini(&body);
        }
        ss_case_fini(&c);
    }
}

TEST(a_dynamic_case_has_its_curves)
{
    ss_case c;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_case_load(REFERENCE "/g_dynamics", &c, &error), SOFTSIM_OK);
    assert_true(c.is_dynamic);
    assert_near(c.first_frequency, 2.23643, 1e-9);
    assert_int_equal(c.step_count, 2);
    assert_near(c.step[1].gravity[2], -2.4525, 0.0);
    assert_near(c.step[1].until, 0.45, 0.0);
    assert_int_equal(c.step[1].count, 401);
    assert_near(c.step[1].time[1], 0.0025, 1e-12);
    assert_near(c.step[1].u[1][2], -7.664062e-06, 1e-12);
    assert_string_equal(c.mesh[0].name, "99");
    ss_case_fini(&c);
}

#define GOOD_HEAD "case: t\nmaterial: {youngs_modulus_pa: 1e4, poisson_ratio: 0.3}\nfixed: fixed\n"
#define GOOD_PUSH "prescribed: {set: patch, direction: [0, 0, -1]}\n"
#define GOOD_REST                                                                                  \
    "levels: {linear: {a: 0.001}}\n"                                                               \
    "meshes: {m: {volume: m.msh, sets: s.json, reference: {linear: r.csv}}}\n"

TEST(hostile_statements_are_refused_with_their_place)
{
    static const says_row bad[] = {
        {"", "empty"},
        {"- a\n", "mapping"},
        {GOOD_HEAD GOOD_PUSH GOOD_REST "colour: red\n", "case.yaml:7:1"},
        {"case: t\nfixed: f\n" GOOD_PUSH GOOD_REST, "'material' is missing"},
        {"case: a/b\nmaterial: {youngs_modulus_pa: 1e4, poisson_ratio: 0.3}\n" GOOD_PUSH GOOD_REST,
         "letters, digits"},
        {GOOD_HEAD "gravity_m_s2: [0, 0, -1]\n" GOOD_REST, "density_kg_m3"},
        {GOOD_HEAD GOOD_PUSH "levels: {\"li'near\": {a: 1}}\nmeshes: {m: {volume: v, sets: s}}\n",
         "plain name"},
        {GOOD_HEAD GOOD_PUSH "levels: {linear: {a: 1}}\nmeshes: {../m: {volume: v, sets: s}}\n",
         "name of a mesh"},
        {"case: t\nmaterial: {youngs_modulus_pa: -1, poisson_ratio: 0.3}\n" GOOD_PUSH GOOD_REST,
         "case.yaml:2:31"},
        {"case: t\nmaterial: {youngs_modulus_pa: 1, poisson_ratio: 0.5}\n" GOOD_PUSH GOOD_REST,
         "must be a number"},
        {GOOD_HEAD GOOD_REST, "nothing loads the body"},
        {GOOD_HEAD "prescribed: {set: patch, direction: [0, 0, -2]}\n" GOOD_REST, "unit vector"},
        {GOOD_HEAD "prescribed: {set: patch, direction: [0, .nan, -1]}\n" GOOD_REST, "number"},
        {GOOD_HEAD "prescribed: {set: patch, direction: [0, 0, -1], axes: z}\n" GOOD_REST,
         "unknown key"},
        {GOOD_HEAD GOOD_PUSH "meshes: {m: {volume: m.msh, sets: s.json}}\n", "'levels' is missing"},
        {GOOD_HEAD GOOD_PUSH "levels: {linear: {a: 0}}\nmeshes: {m: {volume: v, sets: s}}\n",
         "level of nothing"},
        {GOOD_HEAD GOOD_PUSH "levels: {linear: {a: 1}, nh: {}}\nmeshes: {m: {volume: v, sets: "
                             "s}}\n",
         "case.yaml:5:30: error: no level"},
        {GOOD_HEAD GOOD_PUSH "levels: {linear: {a: 1e-3}}\nmeshes: {m: {sets: s.json}}\n",
         "neither a volume nor a surface"},
        {GOOD_HEAD GOOD_PUSH "levels: {linear: {a: 1e-3}}\n", "'meshes' is missing"},
        {GOOD_HEAD GOOD_PUSH GOOD_REST "force: nowhere.csv\n", "nowhere.csv"},
        {GOOD_HEAD GOOD_PUSH GOOD_REST "force: half.csv\n",
         "half.csv: no row for linear at 0.001 m"},
        {"case: t\nkind: dynamic\nmaterial: {youngs_modulus_pa: 1, poisson_ratio: 0, "
         "density_kg_m3: 1}\nmesh_case: " REFERENCE
         "/b_cantilever\nprobe_point_m: [0, 0, 0]\nsteps: [{gravity_m_s2: [0, 0, -1], reference: "
         "curve.csv, compare_until_s: 8}]\n",
         "curve.csv:9: the last time is 7 s"},
        {"case: t\nkind: dynamic\nmaterial: {youngs_modulus_pa: 1, poisson_ratio: 0, "
         "density_kg_m3: 1}\nmesh_case: " REFERENCE
         "/b_cantilever\nprobe_point_m: [0, 0, 0]\nsteps: [{gravity_m_s2: [0, 0, -1], reference: "
         "curve.csv, compare_until_s: 1001}]\n",
         "must be a number of 1e-06 to 1000"},
        {GOOD_HEAD GOOD_PUSH GOOD_REST "kind: slow\n", "static or dynamic"},
        {"case: t\nkind: dynamic\nmaterial: {youngs_modulus_pa: 1, poisson_ratio: 0, "
         "density_kg_m3: "
         "1}\nmesh_case: .\nprobe_point_m: [0, 0, 0]\nsteps: []\n",
         "leads from case to case"},
    };
    write_text("half.csv", "material,depth_m,Fx_N,Fy_N,Fz_N\nlinear,0.002,0,0,-1\n");
    write_text("curve.csv", "t_s,tip_ux_m,tip_uy_m,tip_uz_m\n0,0,0,0\n1,0,0,0\n2,0,0,0\n3,0,0,0\n"
                            "4,0,0,0\n5,0,0,0\n6,0,0,0\n7,0,0,0\n");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        ss_case c;
        softsim_error error = {.status = SOFTSIM_OK};
        write_text("case.yaml", bad[i].given);
        assert_int_not_equal(ss_case_load(folder, &c, &error), SOFTSIM_OK);
        if (strstr(error.text, bad[i].says) == NULL) {
            fail_msg("case %d: no '%s' in: %s", (int)i, bad[i].says, error.text);
        }
        ss_case_fini(&c);
    }
    ss_case c;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_not_equal(ss_case_load("/nowhere", &c, &error), SOFTSIM_OK);
    assert_non_null(strstr(error.text, "/nowhere/case.yaml"));
}

static softsim_status load_tiny(ss_case_body *body, softsim_error *error)
{
    ss_case c;
    *body = (ss_case_body){.mesh = NULL};
    softsim_status status = ss_case_load(folder, &c, error);
    if (status == SOFTSIM_OK) {
        status = ss_case_load_body(&c, &c.mesh[0], 0, false, body, error);
    }
    ss_case_fini(&c);
    return status;
}

static void write_good_case(void)
{
    write_text("case.yaml", GOOD_HEAD GOOD_PUSH GOOD_REST);
    write_text("m.msh", good_mesh);
    write_text("s.json", good_sets);
    write_text("r.csv", good_reference);
}

/* The numbers of the file need not be in order, nor begin with 1. */
TEST(numbers_lead_to_nodes)
{
    ss_case_body body;
    softsim_error error = {.status = SOFTSIM_OK};
    write_good_case();
    assert_int_equal(load_tiny(&body, &error), SOFTSIM_OK);
    assert_int_equal(body.number[0], 7);
    assert_int_equal(body.pushed_count, 1);
    assert_int_equal(body.pushed[0], 3);
    assert_near(body.profile[0], 1.0, 0.0);
    assert_near(body.reference[0][3][2], -0.001, 0.0);
    assert_int_equal(body.fixed[2], 2);
    ss_case_body_fini(&body);
    /* As version 4.1 has them, and other systems end lines. */
    write_text("m.msh", "$MeshFormat\r\n4.1 0 8\r\n$EndMeshFormat\r\n$Nodes\r\n1 4 2 9\r\n"
                        "3 1 0 4\r\n7\r\n3\r\n9\r\n2\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n0 0 1\r\n"
                        "$EndNodes\r\n$Elements\r\n1 1 1 1\r\n3 1 4 1\r\n1 7 3 9 2\r\n"
                        "$EndElements\r\n");
    if (load_tiny(&body, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(body.number[0], 7);
    assert_int_equal(body.number[3], 2);
    ss_case_body_fini(&body);
}

TEST(hostile_bodies_are_refused)
{
    static const struct {
        const char *name, *text, *says;
    } bad[] = {
        {"m.msh", "no mesh", "m.msh"},
        {"m.msh",
         "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n"
         "$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n",
         "no tetrahedra"},
        {"s.json", "{\"fixed\":[7,3,9]}", "needs 'patch'"},
        {"s.json", "{\"fixed\":[7,3,9],\"patch\":[]}", "needs 'patch'"},
        {"s.json", "{\"fixed\":[7,3,9],\"patch\":[4]}", "no node of the mesh"},
        {"s.json", "{\"fixed\":[7,3,9],\"patch\":[2.5]}", "no node of the mesh"},
        {"s.json", "{\"fixed\":[7,3,9],\"patch\":[9]}", "node 9 is in"},
        {"s.json", "{\"fixed\":[7,3,9],\"patch\":[2", "s.json"},
        {"r.csv", "node,x,y,z,w,ux_a,uy_a\n", "only 0 of the mesh's 4 nodes"},
        {"r.csv",
         "node,x,y,z,w,ux_b,uy_b,uz_b\n2,0,0,1,1,0,0,0\n3,1,0,0,1,0,0,0\n7,0,0,0,1,0,0,0\n"
         "9,0,1,0,1,0,0,0\n",
         "no column 'ux_a'"},
        {"r.csv",
         "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,-1,0,0,0\n3,1,0,0,1,0,0,0\n7,0,0,0,1,0,0,0\n"
         "9,0,1,0,1,0,0,0\n",
         "below 0"},
        {"r.csv",
         "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,1,0,nan,0\n3,1,0,0,1,0,0,0\n7,0,0,0,1,0,0,0\n"
         "9,0,1,0,1,0,0,0\n",
         "r.csv:2: column 'uy_a': 'nan' is no number"},
        {"r.csv",
         "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,1,0,0,1e-3\n3,1,0,0,1,0,0,0\n7,0,0,0,1,0,0,0\n"
         "9,0,1,0,1,0,0,0\n\n9,0,1,0,1,0,0,0\n",
         "r.csv:7: a second row for node 9"},
        {"r.csv",
         "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,1,0,0,1e-3\n3,1,0,0,1,0,0,0\n7,0,0,0,1,0,0,0\n"
         "9,0,1,0,1,0,0,0\n10,0,1,0,1,0,0,0\n",
         "r.csv:6: the mesh has no node 10"},
        {"r.csv",
         "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,1,0,0,1e-3\n3,2,0,0,1,0,0,0\n7,0,0,0,1,0,0,0\n"
         "9,0,1,0,1,0,0,0\n",
         "r.csv:3: x is 2, in the mesh it is 1"},
        {"r.csv",
         "node,x,y,z,w,ux_a,uy_a,uz_a\n2,0,0,1,1,0,0,0\n3,1,0,0,1,0,0,0\n7,0,0,0,1,0,0,0\n"
         "9,0,1,0,1,0,0,0\n",
         "nothing to measure"},
        {"m.msh",
         "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n7 0 0 0\n3 1 0 0\n9 0 1 0\n2 0 0 -1\n"
         "$EndNodes\n$Elements\n1\n1 4 2 1 1 7 3 9 2\n$EndElements\n",
         "m.msh: inverted tetrahedra: 1"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        ss_case_body body;
        softsim_error error = {.status = SOFTSIM_OK};
        write_good_case();
        write_text(bad[i].name, bad[i].text);
        assert_int_not_equal(load_tiny(&body, &error), SOFTSIM_OK);
        if (strstr(error.text, bad[i].says) == NULL) {
            fail_msg("body %d: no '%s' in: %s", (int)i, bad[i].says, error.text);
        }
        ss_case_body_fini(&body);
    }
}

/* ---- front, choice ---- */

TEST(the_front_is_what_nothing_beats)
{
    const double time[] = {1.0, 2.0, 2.0, 3.0, 4.0, (double)NAN, 1.0};
    const double error[] = {0.5, 0.4, 0.3, 0.35, 0.1, 0.01, 0.5};
    bool is_front[7];
    ss_accuracy_pareto(7, time, error, is_front);
    const bool expected[7] = {true, false, true, false, true, false, false};
    assert_memory_equal(is_front, expected, sizeof expected);
}

TEST(the_choice_is_the_most_accurate_that_fits)
{
    const ss_accuracy_mean mean[] = {{.error_l2 = 0.4, .p50_us = 10.0},
                                     {.error_l2 = (double)NAN, .p50_us = 1.0},
                                     {.error_l2 = 0.1, .p50_us = 900.0},
                                     {.error_l2 = 0.01, .p50_us = 1001.0}};
    assert_ptr_equal(ss_accuracy_choose(mean, 4, 1000.0), &mean[2]);
    assert_ptr_equal(ss_accuracy_choose(mean, 4, 2000.0), &mean[3]);
    assert_ptr_equal(ss_accuracy_choose(mean, 4, 20.0), &mean[0]);
    assert_null(ss_accuracy_choose(mean, 4, 5.0));
}

/* ---- a whole run ---- */

/* The slab's coarsest surface, linear, pushed (sign 1) or pulled (-1), as a case of its own. */
static void write_slab(double sign)
{
    char text[2048];
    ss_table table;
    softsim_error error = {.status = SOFTSIM_OK};
    snprintf(
        text, sizeof text,
        "case: small\nmaterial: {youngs_modulus_pa: 10000, poisson_ratio: 0.45}\n"
        "fixed: fixed\nprescribed: {set: patch, direction: [0, 0, %g], profile: "
        "patch_profile}\nlevels: {linear: {\"1mm\": 0.001}}\nmeshes: {\"300\": {surface: " REFERENCE
        "/c_slab/surface_300.obj, sets: " REFERENCE
        "/c_slab/nodesets_300.json, reference: {linear: r.csv}}}\nforce: f.csv\n",
        -sign);
    write_text("case.yaml", text);
    snprintf(text, sizeof text, "material,depth_m,Fx_N,Fy_N,Fz_N\nlinear,0.001,0,0,%g\n",
             -0.492161 * sign);
    write_text("f.csv", text);
    assert_int_equal(ss_table_load(REFERENCE "/c_slab/reference_u_linear_300.csv", &table, &error),
                     SOFTSIM_OK);
    FILE *file = open_file("r.csv");
    fputs("node,x,y,z,w,ux_1mm,uy_1mm,uz_1mm\n", file);
    for (int32_t i = 0; i < table.row_count; ++i) {
        for (int32_t k = 0; k < 8; ++k) {
            const double value = ss_table_number(&table, i, k, &error);
            fprintf(file, "%s%.17g", k > 0 ? "," : "", k >= 5 ? sign * value : value);
        }
        fputc('\n', file);
    }
    assert_int_equal(fclose(file), 0);
    ss_table_fini(&table);
}

static int run_bench(const char *const *option)
{
    return run_accuracy(option, stdout, "/dev/null");
}

static void read_rows(const char *name, ss_accuracy_rows *rows)
{
    softsim_error error = {.status = SOFTSIM_OK};
    *rows = (ss_accuracy_rows){.row = NULL};
    assert_int_equal(ss_accuracy_rows_compare(rows, in_folder(name), &error), SOFTSIM_OK);
}

static bool has_text(const char *name, const char *text)
{
    size_t size = 0;
    softsim_error error = {.status = SOFTSIM_OK};
    char *whole = ss_table_read_file(in_folder(name), &size, &error);
    const bool is_there = whole != NULL && strstr(whole, text) != NULL;
    free(whole);
    return is_there;
}

static int count_parts(const char *name)
{
    int count = 0;
    DIR *at = opendir(in_folder(name));
    assert_non_null(at);
    for (const struct dirent *file = readdir(at); file != NULL; file = readdir(at)) {
        count += strstr(file->d_name, ".part") != NULL;
    }
    closedir(at);
    return count;
}

TEST(a_run_leaves_its_rows_pushed_or_pulled)
{
    SKIP_WHERE_REPEATED();
    double field[2];
    if (ss_model_find("cnn-energy") == NULL) {
        skip();
    }
    for (int k = 0; k < 2; ++k) {
        ss_accuracy_rows rows;
        write_slab(k == 0 ? 1.0 : -1.0);
        const char *out = in_folder(k == 0 ? "pushed" : "pulled");
        assert_int_equal(
            run_bench((const char *const[]){"--case", folder, "--model", "cnn-energy", "--quick",
                                            "--budget-us", "1e6", "--out", out, NULL}),
            0);
        read_rows(k == 0 ? "pushed/accuracy.csv" : "pulled/accuracy.csv", &rows);
        assert_int_equal(rows.count, 1);
        const ss_accuracy_row *row = &rows.row[0];
        assert_string_equal(row->case_name, "small");
        assert_string_equal(row->model, "cnn-energy");
        assert_string_equal(row->level, "1mm");
        assert_string_equal(row->calibrated, "yes");
        assert_string_equal(row->verdict, "good");
        assert_int_equal(row->nodes, 304);
        assert_true(row->error_l2 > 0.1 && row->error_l2 <= 0.25);
        assert_true(row->error_max < 0.2);
        assert_true(row->error_force < 0.005); /* calibrated on this very level */
        assert_true(row->p50_us > 0.0 && row->p99_us >= row->p50_us && row->to_1pct_ms > 0.0);
        assert_near(row->dt_s, 1e-3, 0.0);
        field[k] = row->error_l2;
        ss_accuracy_rows_fini(&rows);
        assert_int_equal(count_parts(k == 0 ? "pushed" : "pulled"), 0);
        assert_true(has_text(k == 0 ? "pushed/accuracy.html" : "pulled/accuracy.html",
                             "(fitted on the first of these levels), "));
    }
    assert_near(field[0], field[1], 0.02);
}

TEST(a_second_run_has_nothing_to_resume_and_agrees)
{
    SKIP_WHERE_REPEATED();
    ss_accuracy_rows first, second;
    if (ss_model_find("cnn-energy") == NULL) {
        skip();
    }
    write_slab(1.0);
    read_rows("pushed/accuracy.csv", &first);
    const char *other = write_text(
        "other.csv",
        "case,material,model,mesh,nodes,elements,level,error_l2,error_max,error_force,"
        "us_per_step_p50,us_per_step_p99,dt_s,realtime_factor,time_to_1pct_ms,calibrated,"
        "verdict\nsmall,linear,theirs,x,5,2,1mm,0.01,,,100,,0.001,,,no,\n");
    assert_int_equal(
        run_bench((const char *const[]){"--case", folder, "--model", "cnn-energy", "--quick",
                                        "--compare", other, "--out", in_folder("pushed"), NULL}),
        0);
    read_rows("pushed/accuracy.csv", &second);
    assert_int_equal(second.count, 1); /* others' rows go into the pictures only */
    assert_near(first.row[0].error_l2, second.row[0].error_l2, 0.0);
    assert_near(first.row[0].error_force, second.row[0].error_force, 0.0);
    ss_accuracy_rows_fini(&first);
    ss_accuracy_rows_fini(&second);
    assert_true(has_text("pushed/accuracy.html", "theirs"));
}

/* What linear tetrahedra reach, by the table of the case; NaN: no such row. */
static void find_floor(const ss_table *floor, const ss_accuracy_row *row, double *out_field,
                       double *out_force)
{
    softsim_error error = {.status = SOFTSIM_OK};
    const int32_t force = ss_table_find(floor, "F_err_pct", NULL);
    *out_field = *out_force = (double)NAN;
    for (int32_t i = 0; i < floor->row_count; ++i) {
        char level[32];
        snprintf(level, sizeof level, "%s", ss_table_cell(floor, i, 1));
        for (char *at = level; *at != '\0'; ++at) {
            *at = *at == '.' ? 'p' : *at;
        }
        if (strcmp(ss_table_cell(floor, i, 0), row->material) == 0 &&
            strcmp(ss_table_cell(floor, i, 2), row->mesh) == 0 && strcmp(level, row->level) == 0) {
            *out_field =
                0.01 * ss_table_number(floor, i, ss_table_find(floor, "L2_err_pct", NULL), &error);
            *out_force = force < 0 ? (double)NAN : 0.01 * ss_table_number(floor, i, force, &error);
        }
    }
}

/* At nu = 0.3 the element's own error to 1 %; at 0.45 no worse, and with the cure for locking
 * better than any plain element can be. */
TEST(fem_reaches_the_floor_of_linear_tetrahedra)
{
    SKIP_WHERE_REPEATED();
    static const char *const run[][3] = {{"b_cantilever", "99", "locking_cure=auto"},
                                         {"c_slab", "300", "locking_cure=auto"},
                                         {"c_slab", "300", "locking_cure=nodal-pressure"}};
    if (ss_model_find("fem") == NULL) {
        skip();
    }
    for (size_t k = 0; k < sizeof run / sizeof *run; ++k) {
        char path[512], csv[64];
        ss_accuracy_rows rows;
        ss_table floor;
        softsim_error error = {.status = SOFTSIM_OK};
        snprintf(path, sizeof path, REFERENCE "/%s", run[k][0]);
        const char *out = in_folder(run[k][0]);
        assert_int_equal(
            run_bench((const char *const[]){"--case", path, "--model", "fem", "--mesh", run[k][1],
                                            "--set", run[k][2], "--quick", "--out", out, NULL}),
            0);
        snprintf(csv, sizeof csv, "%s/accuracy.csv", run[k][0]);
        read_rows(csv, &rows);
        assert_int_equal(rows.count, 5);
        snprintf(path, sizeof path, REFERENCE "/%s/linear_tet_floor.csv", run[k][0]);
        assert_int_equal(ss_table_load(path, &floor, &error), SOFTSIM_OK);
        for (int32_t i = 0; i < rows.count; ++i) {
            const ss_accuracy_row *row = &rows.row[i];
            double field, force;
            find_floor(&floor, row, &field, &force);
            assert_string_equal(row->calibrated, "no");
            assert_true(row->error_l2 <= (k == 2 ? 0.85 : 1.01) * field);
            assert_true(k > 0 || row->error_l2 >= 0.98 * field);
            assert_true(k == 0 || 1.0 + row->error_force <= 1.01 * (1.0 + force));
        }
        ss_table_fini(&floor);
        ss_accuracy_rows_fini(&rows);
    }
}

/* Twice as fine: the same volume, eight times the elements, sets on the same faces. */
TEST(refinement_keeps_the_body)
{
    ss_case c;
    ss_case_body body, fine;
    softsim_error error = {.status = SOFTSIM_OK};
    ss_mesh_report report;
    double volume = 0.0;
    assert_int_equal(ss_case_load(REFERENCE "/c_slab", &c, &error), SOFTSIM_OK);
    assert_int_equal(ss_case_load_body(&c, &c.mesh[0], -1, false, &body, &error), SOFTSIM_OK);
    assert_int_equal(ss_refine(&body, &fine, &error), SOFTSIM_OK);
    assert_int_equal(fine.mesh->tetrahedron_count, 8 * body.mesh->tetrahedron_count);
    assert_int_equal(fine.mesh->triangle_count, 4 * body.mesh->triangle_count);
    assert_int_equal(ss_mesh_check(fine.mesh, &report), SOFTSIM_OK);
    assert_int_equal(report.inverted_tetrahedron.count + report.flat_tetrahedron.count +
                         report.open_edge.count + report.duplicate_tetrahedron.count,
                     0);
    for (int32_t i = 0; i < fine.mesh->node_count; ++i) {
        volume += fine.weight[i];
    }
    assert_near(volume, 0.1 * 0.1 * 0.05, 1e-10);
    for (int32_t i = 0; i < fine.fixed_count; ++i) {
        assert_near(fine.mesh->position[fine.fixed[i]][2], 0.0, 1e-12);
    }
    assert_true(fine.fixed_count > 3 * body.fixed_count);
    assert_true(fine.pushed_count > 3 * body.pushed_count);
    for (int32_t i = 0; i < fine.pushed_count; ++i) {
        assert_near(fine.mesh->position[fine.pushed[i]][2], 0.05, 1e-12);
        assert_true(fine.profile[i] >= 0.5 && fine.profile[i] < 0.92);
    }
    ss_case_body_fini(&body);
    ss_case_body_fini(&fine);
    ss_case_fini(&c);
}

TEST(bad_commands_end_with_2)
{
    const char *out = in_folder("none");
    write_slab(1.0);
    const char *const commands[][9] = {
        {"--case", "/nowhere", "--out", out, NULL},
        {"--case", folder, "--model", "clay", "--out", out, NULL},
        {"--case", folder, "--mesh", "none", "--out", out, NULL},
        {"--case", folder, "--mesh", "300,3000", "--quick", "--out", out, NULL},
        {"--case", folder, "--case", folder, "--out", out, NULL},
        {"--budget-us", "-1", NULL},
    };
    for (size_t i = 0; i < sizeof commands / sizeof *commands; ++i) {
        assert_int_equal(run_bench(commands[i]), 2);
        assert_int_not_equal(access(out, F_OK), 0);
    }
}

/* ---- setup ---- */

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
