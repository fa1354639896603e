/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-mesh info, check, convert and tetrahedralize. */
#include "common/test.h"

#include <math.h>
#include <sys/stat.h>

#include "common/tool_fixture.h"

#define CUBE_V "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
#define CUBE_F                                                                                     \
    "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\n"   \
    "f 2 4 8\nf 2 8 6\n"
#define MSH(nodes, elements)                                                                       \
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" nodes "$EndNodes\n$Elements\n" elements       \
    "$EndElements\n"
#define CORNERS "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"

/* ---- check: each fault, its count, first numbers and exit status ---- */

static const struct {
    const char *name, *text;
    int status;
    const char *finding; /* in the JSON */
    const char *says;    /* in the text */
} faults[] = {
    {"good.obj", CUBE_V CUBE_F, 0, "\"findings\": []", "good.obj: good"},
    {"tetrahedron.msh", MSH("4\n" CORNERS, "1\n1 4 2 0 1 1 2 3 4\n"), 0, "\"findings\": []",
     "tetrahedron.msh: good"},
    {"empty.obj", "", 2, "\"error\": ", "empty.obj"},
    {"empty.msh", MSH("0\n", "0\n"), 2, "\"error\": ", "empty.msh"},
    {"text.msh", "hello\n", 2, "\"error\": ", "text.msh"},
    {"nan.obj", "v 0 0 nan\n" CUBE_F, 2, "\"error\": ", "nan.obj:1: the position"},
    {"index.obj", CUBE_V CUBE_F "f 1 2 77\n", 2, "\"error\": ", "index.obj"},
    {"index.msh", MSH("4\n" CORNERS, "1\n1 4 2 0 1 1 2 3 9\n"), 2, "\"error\": ", "index.msh:13: "},
    {"open.obj", CUBE_V "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\n",
     1,
     "{\"key\": \"hole\", \"count\": 2, \"status\": 1, \"is_refused\": false, \"first\": [0, 1], ",
     "open edges: 8 (at node 0, 0, 1, 1, 2, ...)"},
    {"reversed.obj",
     CUBE_V "f 4 3 1\nf 2 4 1\nf 8 6 5\nf 7 8 5\nf 6 2 1\nf 5 6 1\nf 8 7 3\nf 4 8 3\nf 7 5 1\n"
            "f 3 7 1\nf 8 4 2\nf 6 8 2\n",
     1, "{\"key\": \"inside_out\", \"count\": 1, \"status\": 1, \"is_refused\": true, ",
     "inside out: flip it"},
    {"turned.obj",
     CUBE_V "f 4 3 1\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\n"
            "f 1 7 3\nf 2 4 8\nf 2 8 6\n",
     2, "{\"key\": \"inconsistent_winding\", \"count\": 3, ", "wound against each other: 3"},
    {"parts.obj",
     CUBE_V CUBE_F
     "v 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\nf 9 11 10\nf 9 10 12\nf 9 12 11\nf 10 11 12\n",
     1, "{\"key\": \"component\", \"count\": 2, ", "separate parts: 2"},
    {"crossing.obj",
     CUBE_V CUBE_F "v .5 .5 .5\nv 2 .5 .5\nv .5 2 .5\nv .5 .5 2\nf 9 11 10\nf 9 10 12\nf 9 12 11\n"
                   "f 10 11 12\n",
     1, "{\"key\": \"self_intersection\", \"count\": ", "triangles that cross others: "},
    {"loose.obj", CUBE_V "v 7 7 7\n" CUBE_F, 1, "{\"key\": \"unused_node\", \"count\": 1, ",
     "vertices without a face, left out as the file was read: 1"},
    {"coincident.obj",
     CUBE_V "v 1 1 1\nf 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\n"
            "f 1 5 7\nf 1 7 3\nf 2 4 9\nf 2 9 6\n",
     1, "{\"key\": \"joined_node\", \"count\": 1, ", "vertices on top of others, joined"},
    {"loose.msh", MSH("5\n" CORNERS "5 9 9 9\n", "1\n1 4 2 0 1 1 2 3 4\n"), 1,
     "{\"key\": \"loose_node\", \"count\": 1, \"status\": 1, \"is_refused\": true, \"first\": "
     "[4], ",
     "nodes without an element: 1 (node 4)"},
    {"coincident.msh",
     MSH("8\n" CORNERS "5 0 0 0\n6 -1 0 0\n7 0 -1 0\n8 0 0 -1\n",
         "2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 5 7 6 8\n"),
     1,
     "{\"key\": \"coincident_node\", \"count\": 1, \"status\": 1, \"is_refused\": true, \"first\": "
     "[4], ",
     "nodes on top of others: 1 (node 4)"},
    {"sliver.msh", MSH("4\n1 0 0 0\n2 1 1 0\n3 1 0 .05\n4 0 1 .05\n", "1\n1 4 2 0 1 1 2 4 3\n"), 1,
     "{\"key\": \"sliver\", \"count\": 1, \"status\": 1, \"is_refused\": false, \"first\": [0], ",
     "outside 10 to 170 degrees"},
    {"inverted.msh", MSH("4\n" CORNERS, "1\n1 4 2 0 1 1 2 4 3\n"), 1,
     "{\"key\": \"inverted_tetrahedron\", \"count\": 1, \"status\": 1, \"is_refused\": true, ",
     "inverted tetrahedra: 1 (tetrahedron 0)"},
    {"mixed.msh", MSH("5\n" CORNERS "5 0 0 -1\n", "2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 3 5\n"), 2,
     "{\"key\": \"inverted_tetrahedron\", \"count\": 1, \"status\": 2, \"is_refused\": true, "
     "\"first\": [1], ",
     "inverted tetrahedra: 1 (tetrahedron 1)"},
    /* A node drawn through its neighbours, and the tetrahedron there written with a positive
       volume. */
    {"through.msh", MSH("5\n" CORNERS "5 .2 .2 .4\n", "2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 3 5\n"),
     2,
     "{\"key\": \"overlapping_tetrahedron\", \"count\": 2, \"status\": 2, \"is_refused\": true, "
     "\"first\": [0, 1], ",
     "tetrahedra that overlap their neighbours: 2 (tetrahedron 0, 1)"},
    {"huge.msh", MSH("4\n1 0 0 0\n2 1e308 0 0\n3 0 1 0\n4 0 0 1\n", "1\n1 4 2 0 1 1 2 3 4\n"), 2,
     "\"error\": ", "huge.msh:7: node 1: its position is not finite, or beyond 1e60"},
    {"large.msh", MSH("4\n1 0 0 0\n2 1e30 0 0\n3 0 1e30 0\n4 0 0 1e30\n", "1\n1 4 2 0 1 1 2 3 4\n"),
     2, "{\"key\": \"size\", \"count\": 1, \"status\": 2, \"is_refused\": true, ",
     "a size that no scene takes (1e-7 to 1e5 m across)"},
    {"small.msh",
     MSH("4\n1 0 0 0\n2 1e-30 0 0\n3 0 1e-30 0\n4 0 0 1e-30\n", "1\n1 4 2 0 1 1 2 3 4\n"), 2,
     "{\"key\": \"size\", \"count\": 1, \"status\": 2, \"is_refused\": true, ",
     "a size that no scene takes (1e-7 to 1e5 m across)"},
    {"flat.msh", MSH("5\n" CORNERS "5 1 1 0\n", "2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 5 3\n"), 2,
     "{\"key\": \"flat_tetrahedron\", \"count\": 1, \"status\": 2, \"is_refused\": true, "
     "\"first\": "
     "[1], ",
     "without a volume: 1 (tetrahedron 1)"},
    {"twice.msh", MSH("4\n" CORNERS, "2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 2 3 1 4\n"), 2,
     "{\"key\": \"duplicate_tetrahedron\", \"count\": 1, \"status\": 2, \"is_refused\": true, "
     "\"first\": [1], ",
     "duplicate tetrahedra: 1 (tetrahedron 1)"},
    {"face.msh",
     MSH("6\n" CORNERS "5 0 0 -1\n6 1 1 2\n",
         "3\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 3 2 5\n3 4 2 0 1 1 2 3 6\n"),
     2,
     "{\"key\": \"crowded_face\", \"count\": 1, \"status\": 2, \"is_refused\": true, \"first\": "
     "[0], ",
     "faces of more than two tetrahedra: 1 (at node 0)"},
    {"skipped.msh", MSH("4\n" CORNERS, "2\n1 4 2 0 1 1 2 3 4\n2 17 2 0 1 1 2 3 4\n"), 1,
     "{\"key\": \"skipped_element\", \"count\": 1, \"status\": 1, \"is_refused\": false, ",
     "elements of kinds that no model has, left out: 1"},
    {"edge.obj", CUBE_V CUBE_F "v 2 2 .5\nf 2 9 4\n", 2,
     "{\"key\": \"non_manifold_edge\", \"count\": 1, \"status\": 2, \"is_refused\": true, "
     "\"first\": [",
     "edges of more than two triangles: 1 (at node 1)"},
};

TEST(each_fault_has_its_count_numbers_and_exit_status)
{
    for (int32_t i = 0; i < COUNT(faults); ++i) {
        char command[256];
        char out[16384];
        write_text(faults[i].name, faults[i].text);
        (void)snprintf(command, sizeof command, TOOL "check %s", faults[i].name);
        int status = run(command, out, sizeof out);
        if (status != faults[i].status || strstr(out, faults[i].says) == NULL) {
            fail_msg("%s: %d: %s", faults[i].name, status, out);
        }
        (void)snprintf(command, sizeof command, TOOL "check --json %s", faults[i].name);
        status = run(command, out, sizeof out);
        if (status != faults[i].status || strstr(out, faults[i].finding) == NULL) {
            fail_msg("%s: %d: %s", faults[i].name, status, out);
        }
    }
}

TEST(lengths_are_the_files_own_unless_units_are_given)
{
    char out[8192];
    write_text("two.obj",
               "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    assert_int_equal(run(TOOL "check two.obj", out, sizeof out), 0);
    assert_non_null(strstr(out, "box         0 0 0 to 2 2 2\n"));
    assert_non_null(strstr(out, "volume      1.33333\n"));
    assert_non_null(strstr(out, "taken as 1 mm"));
    assert_non_null(strstr(out, "the models' figures take it as mm"));
    assert_non_null(strstr(out, "edge        2 least, 2.41421 mean, 2.82843 greatest\n"));
    assert_non_null(strstr(out, "angles      40-50: 3  "));
    assert_int_equal(run(TOOL "check two.obj --units cm", out, sizeof out), 0);
    assert_non_null(strstr(out, "box         0 0 0 to 0.02 0.02 0.02\n"));
    assert_null(strstr(out, "taken as 1 mm"));
    assert_int_equal(run(TOOL "info two.obj --units cm --json", out, sizeof out), 0);
    assert_non_null(strstr(out,
                           "\"unit\": \"m\", \"box_min\": [0, 0, 0], \"box_max\": [0.02, 0.02, "
                           "0.02]"));
    assert_non_null(strstr(out, "\"nodes\": 4, \"triangles\": 4, \"quads\": 0, \"tetrahedra\": 0"));
    assert_int_equal(run(TOOL "info two.obj --nodes", out, sizeof out), 0);
    assert_non_null(strstr(out, "node,x,y,z\n0,0,0,0\n1,2,0,0\n"));
}

static double number_after(const char *text, const char *word)
{
    const char *at = strstr(text, word);
    if (at == NULL) {
        fail_msg("no '%s' in %s", word, text);
        return 0.0;
    }
    return strtod(at + strlen(word), NULL);
}

TEST(each_model_tells_its_stable_step_and_memory)
{
    char out[8192];
    double bytes[2];
    for (int i = 0; i < 2; ++i) {
        char command[256];
        (void)snprintf(command, sizeof command,
                       TOOL "generate kidney --points %d --out k.obj && " TOOL
                            "check k.obj --units mm --json",
                       i == 0 ? 300 : 1200);
        assert_int_equal(run(command, out, sizeof out), 0);
        const double step = number_after(out, "{\"name\": \"cnn-energy\", \"stable_step_s\": ");
        assert_true(step > 1e-6 && step < 1.0);
        bytes[i] = number_after(out, "\"bytes\": ");
    }
    assert_true(bytes[1] > 2.0 * bytes[0] && bytes[1] < 8.0 * bytes[0]);
    assert_non_null(strstr(out, "\"material\": \"soft tissue: 3 kPa, Poisson's ratio 0.45; surface "
                                "networks: 5 J"));
    assert_int_equal(run(TOOL "generate block --tetrahedra --points 200 --out f.msh && " TOOL
                              "check f.msh --units mm --json",
                         out, sizeof out),
                     0);
    const double step = number_after(out, "{\"name\": \"fem\", \"stable_step_s\": ");
    assert_true(step > 1e-4 && step < 1e-1); /* cells of 17 mm, sound at 3.4 m/s */
    assert_int_equal(run(TOOL "check f.msh --units mm", out, sizeof out), 0);
    assert_non_null(strstr(out, "corotational: stable at any step, "));
    assert_non_null(strstr(out, "hybrid: it needs layer.spacing_m, which is the scene's\n"));
}

/* ---- convert ---- */

TEST(formats_and_units_are_converted)
{
    char out[4096];
    write_text("good.obj", CUBE_V CUBE_F);
    assert_int_equal(run(TOOL "convert good.obj good.msh --units m --to-units mm", out, sizeof out),
                     0);
    assert_non_null(strstr(out, "good.msh: 8 nodes, 12 triangles\n"));
    ss_mesh *m = load(in_folder("good.msh"), 1.0);
    assert_near(m->position[7][2], 1000.0, 0.0);
    ss_mesh_destroy(&m);
    assert_int_equal(run(TOOL "generate block --tetrahedra --points 100 --out b.msh && " TOOL
                              "convert b.msh c.msh && cmp b.msh c.msh && " TOOL
                              "convert b.msh b.obj && " TOOL "convert b.msh b.vtk && " TOOL
                              "convert b.vtk d.msh && cmp b.msh d.msh",
                         out, sizeof out),
                     0);
    assert_non_null(strstr(out, "of which the surface: "));
    m = load(in_folder("b.obj"), 1e-3);
    assert_true(m->is_closed);
    ss_mesh_destroy(&m);
}

/* The volume of a cube whose corners single precision has, by the divergence theorem of what is
 * read; bytes by the format's own count. */
TEST(stl_is_written_as_it_is_read)
{
    char out[4096];
    write_text("good.obj", CUBE_V CUBE_F);
    run_tool("convert good.obj good.stl");
    assert_int_equal(run("wc -c < good.stl", out, sizeof out), 0);
    assert_int_equal(atoi(out), 80 + 4 + 12 * 50);
    ss_mesh *m = load(in_folder("good.stl"), 1.0);
    ss_mesh_report r;
    assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
    assert_true(m->is_closed && m->node_count == 8 && m->triangle_count == 12);
    assert_near(r.volume, 1.0, 1e-12);
    ss_mesh_destroy(&m);
    /* A third is no single: what is mended is judged as it will be read. */
    write_text("third.obj", "v 0 0 0\nv .333333333333 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n"
                            "f 1 4 3\nf 2 3 4\n");
    run_tool("convert --repair third.obj third.stl");
    run_tool("check third.stl");
}

/* Doubles that no single is near would be written as infinite. */
TEST(stl_holds_no_position_that_is_not_finite)
{
    char out[4096];
    write_text("far.msh",
               MSH("4\n1 0 0 0\n2 1e39 0 0\n3 0 1e39 0\n4 0 0 1e39\n", "1\n1 4 2 0 1 1 2 3 4\n"));
    run_tool("convert far.msh far.vtk");
    assert_int_equal(run(TOOL "convert far.msh far.stl", out, sizeof out), 2);
    assert_non_null(strstr(out, "far.stl: node 1 is beyond what STL can say (3.4e+38)"));
    assert_int_equal(access(in_folder("far.stl"), F_OK), -1);
}

/* Of the table above. */
TEST(repair_writes_nothing_that_check_refuses)
{
    static const char *const names[] = {"through.msh", "large.msh", "small.msh", "huge.msh"};
    char command[256], out[8192];
    for (int32_t i = 0; i < COUNT(names); ++i) {
        (void)snprintf(command, sizeof command,
                       "rm -f no.msh; " TOOL
                       "check %s >/dev/null 2>&1; test $? = 2 || exit 9; " TOOL
                       "convert --repair %s no.msh",
                       names[i], names[i]);
        if (run(command, out, sizeof out) != 2 || access(in_folder("no.msh"), F_OK) == 0) {
            fail_msg("%s: %s", names[i], out);
        }
    }
}

/* 50,000 copies of one face took all the looks that the search for crossings has. */
TEST(faces_that_are_there_many_times_cost_no_more_than_once)
{
    enum { COPIES = 50000 };
    FILE *file = fopen(in_folder("copies.msh"), "w");
    assert_non_null(file);
    (void)fprintf(file,
                  "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n" CORNERS
                  "$EndNodes\n$Elements\n%d\n1 2 2 0 1 1 3 2\n2 2 2 0 1 1 4 3\n"
                  "3 2 2 0 1 2 3 4\n",
                  COPIES + 3);
    for (int i = 0; i < COPIES; ++i) {
        (void)fprintf(file, "%d 2 2 0 1 1 2 4\n", i + 4);
    }
    (void)fprintf(file, "$EndElements\n");
    assert_int_equal(fclose(file), 0);
    char out[8192];
    assert_int_equal(run(TOOL "check copies.msh", out, sizeof out), 2);
    assert_non_null(strstr(out, "duplicate triangles: 49999"));
    assert_null(strstr(out, "too many triangles lie about each other"));
}

TEST(the_order_of_tetrahedra_is_told_and_changed)
{
    char out[8192];
    write_text("one.msh", MSH("4\n" CORNERS, "1\n1 4 2 0 1 1 2 3 4\n"));
    write_text("flat.obj", CUBE_V CUBE_F);
    static const tool_row rows[] = {
        {"convert one.msh two.vtk --order 2", 0, "10 nodes, 1 tetrahedra of second order"},
        {"info two.vtk", 0, "order       2 (a node on every edge"},
        {"info two.vtk --json", 0, "\"order\": 2"},
        {"check two.vtk --units m", 0, "fem-quadratic: stable step"},
        {"check two.vtk --units m", 0, " fem: it takes no mesh of second order: softsim-mesh "},
        {"convert two.vtk back.msh --order 1", 0, "4 nodes, 1 tetrahedra of dihedral"},
        {"info back.msh --json", 0, "\"order\": 1"},
        {"convert flat.obj no.msh --order 2", 2, "a surface has no second order"},
        {"convert one.msh no.msh --order 3", 2, "--order"},
    };
    expect_answers(rows, COUNT(rows));
    run_tool("convert one.msh as-is.msh");
    assert_int_equal(run("cmp back.msh as-is.msh", out, sizeof out), 0);
}

TEST(repair_tells_each_change_and_what_comes_out_is_good)
{
    char out[4096];
    /* Kuhn's six of a cube, two inverted; node 9 loose, 10 on top of 1; the third is there
     * twice.
     */
    write_text("broken.msh",
               MSH("10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 0 0 1\n6 1 0 1\n7 0 1 1\n8 1 1 1\n"
                   "9 5 5 5\n10 0 0 0\n",
                   "7\n1 4 2 0 1 1 2 4 8\n2 4 2 0 1 1 3 4 8\n3 4 2 0 1 1 3 7 8\n4 4 2 0 1 1 7 5 8\n"
                   "5 4 2 0 1 1 6 5 8\n6 4 2 0 1 10 6 2 8\n7 4 2 0 1 3 7 1 8\n"));
    assert_int_equal(run(TOOL "check broken.msh", out, sizeof out), 2);
    assert_int_equal(run(TOOL "convert broken.msh mended.msh --repair", out, sizeof out), 0);
    const char *const changes[] = {"broken.msh: nodes welded to others: 1 (node 9)\n",
                                   "broken.msh: duplicate elements dropped: 1 (tetrahedron 6)\n",
                                   "broken.msh: loose nodes dropped: 1 (node 8)\n",
                                   "broken.msh: tetrahedra turned: 2 (tetrahedron 1, 4)\n",
                                   "mended.msh: 8 nodes, 6 tetrahedra"};
    for (int32_t i = 0; i < COUNT(changes); ++i) {
        if (strstr(out, changes[i]) == NULL) {
            fail_msg("no '%s' in %s", changes[i], out);
        }
    }
    run_tool("check mended.msh");
    /* Without --repair the mesh goes as it is. */
    run_tool("convert broken.msh same.msh");
    assert_int_equal(run(TOOL "check same.msh", out, sizeof out), 2);
}

TEST(repair_tells_what_it_leaves)
{
    char out[4096];
    /* A pyramid without its base, one side twice. */
    write_text("hole.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .5 1\n"
                           "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 1 2 5\n");
    assert_int_equal(run(TOOL "convert hole.obj whole.obj --repair", out, sizeof out), 0);
    assert_non_null(strstr(out, "hole.obj: duplicate elements dropped: 1 (face 4)\n"));
    assert_non_null(strstr(out, "hole.obj: left as they are: holes: 1 (at node "));
    write_text("mine.obj", CUBE_V CUBE_F);
    assert_int_equal(run(TOOL "convert mine.obj whole.obj --repair", out, sizeof out), 0);
    assert_null(strstr(out, "left as they are"));
}

/* One triangle of it is long and thin. */
#define NEEDLE "v 0 0 0\nv 1 0 0\nv 0 .05 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

TEST(a_surface_is_evened_out)
{
    char out[8192];
    write_text("mine.obj", CUBE_V CUBE_F);
    write_text("two.msh", MSH("4\n" CORNERS, "1\n1 4 2 0 1 1 2 3 4\n"));
    write_text("fin.obj", CUBE_V CUBE_F "v 2 2 .5\nf 2 9 4\n");
    static const tool_row rows[] = {
        {"remesh mine.obj even.msh --edge 0.2", 0, ", 0 slivers, volume 1\neven.msh: at most "},
        {"remesh mine.obj even2.msh --edge-mm 200 --units m", 0, ", 0 slivers, volume 1\n"},
        {"check even.msh", 0, "even.msh: good"},
        {"remesh mine.obj even.msh", 2, "give one of --edge-mm and --edge"},
        {"remesh mine.obj even.msh --edge 0.2 --edge-mm 1", 2, "give one of"},
        {"remesh mine.obj mine.obj --edge 0.2", 2, "mine.obj"},
        {"remesh two.msh even.msh --edge 0.2", 2, "two.msh: it has tetrahedra: give its surface"},
        {"remesh fin.obj even.msh --edge 0.2", 2, "mend it first: softsim-mesh convert --repair"},
        {"remesh mine.obj even.msh --edge 1e-5", 2, "more than 4 million triangles"},
    };
    expect_answers(rows, COUNT(rows));
    assert_int_equal(run("cmp even.msh even2.msh", out, sizeof out), 0);
    /* A needle of a triangle: the words of check name the command. */
    write_text("needle.obj", NEEDLE);
    assert_int_equal(run(TOOL "check needle.obj", out, sizeof out), 1);
    assert_non_null(strstr(out, "worst: softsim-mesh remesh IN OUT --edge-mm N"));
    assert_non_null(strstr(out, "model       mass-spring: a surface mesh needs thickness_m"));
}

/* What check names for slivers is taken, or what is to be done first is said. */
TEST(only_what_remesh_takes_is_sent_there)
{
    char out[8192];
    write_text("crossed.obj", NEEDLE "v .1 .01 .1\nv 2 .01 .1\nv .1 2 .1\nv .1 .01 2\nf 5 7 6\n"
                                     "f 5 6 8\nf 5 8 7\nf 6 7 8\n");
    assert_int_equal(run(TOOL "check crossed.obj", out, sizeof out), 1);
    assert_non_null(strstr(out, "worst: once nothing crosses, softsim-mesh remesh IN OUT"));
    write_text("finned.obj", NEEDLE "v 2 2 .5\nf 2 5 4\n");
    (void)run(TOOL "check finned.obj", out, sizeof out);
    assert_non_null(strstr(out, "worst: once it is mended (softsim-mesh convert --repair), softsim-"
                                "mesh remesh IN OUT"));
    static const tool_row rows[] = {
        {"remesh crossed.obj even.msh --edge 0.2", 2, "triangles cross others"},
        {"remesh finned.obj even.msh --edge 0.2", 2, "mend it first"},
        {"remesh needle.obj even.msh --edge 0.02", 0, "even.msh: at most "},
    };
    write_text("needle.obj", NEEDLE);
    expect_answers(rows, COUNT(rows));
}

/* The help names the groups that are written, and no others. */
TEST(help_names_the_groups_of_each_shape)
{
    static const char *const shapes[] = {"kidney",     "liver", "ellipsoid", "ventricle",
                                         "ellipsoids", "block", "beam",      "cylinder"};
    char help[8192], out[8192], command[256];
    assert_int_equal(run(TOOL "generate --help", help, sizeof help), 0);
    for (int32_t i = 0; i < COUNT(shapes); ++i) {
        char expected[320], got[256] = "";
        (void)snprintf(command, sizeof command,
                       TOOL "generate %s --tetrahedra --points 300 --out g.msh && " TOOL
                            "info g.msh",
                       shapes[i]);
        assert_int_equal(run(command, out, sizeof out), 0);
        for (const char *at = out; (at = strstr(at, "\ngroup       ")) != NULL;) {
            at += strlen("\ngroup       ");
            const size_t used = strlen(got);
            (void)snprintf(got + used, sizeof got - used, "%s%.*s", used > 0 ? ", " : "",
                           (int)strcspn(at, ":"), at);
        }
        (void)snprintf(expected, sizeof expected, "\n  %-12s %s%s\n", shapes[i], got,
                       strcmp(shapes[i], "cylinder") == 0 ? " (with --tetrahedra)" : "");
        if ((strstr(help, expected) != NULL) != (got[0] != '\0')) {
            fail_msg("no '%s' in %s", expected, help);
        }
    }
}

TEST(the_input_is_replaced_only_when_asked)
{
    write_text("mine.obj", CUBE_V CUBE_F);
    static const tool_row rows[] = {
        {"convert mine.obj mine.obj", 2, "'mine.obj' is the input"},
        {"convert mine.obj ./mine.obj", 2, "is the input"},
        {"convert mine.obj mine.obj --overwrite", 0, "mine.obj: 8 nodes"},
        {"convert mine.obj mine.gltf", 2, "ends in none of .obj, .msh, .vtk, .stl"},
        {"convert mine.obj x.msh --to-units m", 2, "give --units too"},
        {"convert mine.obj no/such.msh", 1, "cannot write it"},
        {"convert mine.obj", 2, "usage"},
        {"convert none.obj x.msh", 2, "none.obj: cannot read it"},
    };
    expect_answers(rows, COUNT(rows));
    ss_mesh *m = load(in_folder("mine.obj"), 1.0);
    assert_int_equal(m->triangle_count, 12);
    ss_mesh_destroy(&m);
}

/* ---- tetrahedralize ---- */

/* With a program of that name, or none, on the path. */
TEST(tetgen_that_is_missing_or_fails_is_one_error)
{
    char out[4096];
    write_text("good.obj", CUBE_V CUBE_F);
    write_text("open.obj", CUBE_V "f 1 3 4\nf 1 4 2\n");
    const struct {
        const char *script, *arguments;
        int status;
        const char *says;
    } cases[] = {
        {NULL, "good.obj t.msh --edge 1", 1, "install Debian's package tetgen"},
        {"exit 3", "good.obj t.msh --edge 1", 1, "exit status 3: it gave no reason"},
        {"echo first; echo bad facet >&2; exit 1", "good.obj t.msh --edge 1", 1,
         "exit status 1: bad facet"},
        {"kill -SEGV $$", "good.obj t.msh --edge 1", 1, "crashed (signal 11)"},
        {"exec /bin/sleep 100", "good.obj t.msh --edge 1 --timeout-s 0.2", 1,
         "not done after 0.2 s"},
        {"exit 0", "good.obj t.msh --edge 1", 1, "in.1.node"},
        {"exit 0", "open.obj t.msh --edge 1", 2, "open.obj: open edges: 4"},
        {"exit 0", "good.obj t.obj --edge 1", 2, "name a .msh or .vtk file"},
        {"exit 0", "good.obj t.msh", 2, "give one of --edge and --edge-mm"},
        {"exit 0", "good.obj t.msh --edge 1 --edge-mm 1", 2, "give one of"},
        {"exit 0", "b.msh t.msh --edge 1", 2, "it has tetrahedra already"},
    };
    run_tool("generate block --tetrahedra --points 100 --out b.msh");
    for (int32_t i = 0; i < COUNT(cases); ++i) {
        char command[512];
        assert_int_equal(run("rm -rf bin && mkdir bin", out, sizeof out), 0);
        if (cases[i].script != NULL) {
            char script[256];
            (void)snprintf(script, sizeof script, "#!/bin/sh\n%s\n", cases[i].script);
            write_text("bin/tetgen", script);
            assert_int_equal(chmod(in_folder("bin/tetgen"), 0755), 0);
        }
        (void)snprintf(command, sizeof command,
                       "mkdir -p tmp && PATH=$PWD/bin TMPDIR=$PWD/tmp " TOOL "tetrahedralize %s",
                       cases[i].arguments);
        const int status = run(command, out, sizeof out);
        if (status != cases[i].status || strstr(out, cases[i].says) == NULL) {
            fail_msg("%s, %s: %d: %s", cases[i].script, cases[i].arguments, status, out);
        }
        /* Nothing is left behind. */
        assert_int_equal(run("rmdir tmp && test ! -e t.msh", out, sizeof out), 0);
    }
}

TEST(a_kidney_is_filled_and_its_surface_keeps_its_numbers)
{
    char out[4096];
    if (run("command -v tetgen", out, sizeof out) != 0) {
        print_message("tetgen is not installed: not tested\n");
        skip();
    }
    const char *kidney = SOURCE_DIR "/server/scenes/kidney.obj";
    run_tool("tetrahedralize %s k.msh --edge-mm 6 --units mm", kidney);
    run_tool("check k.msh --units mm");
    ss_mesh *volume = load(in_folder("k.msh"), 1.0);
    ss_mesh *surface = NULL;
    assert_int_equal(ss_mesh_load(kidney, 1.0, BIN_DIR "/softsim-import", &surface, NULL),
                     SOFTSIM_OK);
    assert_true(volume->tetrahedron_count > 3000);
    assert_int_equal(volume->triangle_count, surface->triangle_count);
    assert_nodes_near(volume, surface, 1e-9);
    run_tool("tetrahedralize %s k2.vtk --edge-mm 6 --units mm --order 2", kidney);
    run_tool("check k2.vtk --units mm");
    ss_mesh *second = load(in_folder("k2.vtk"), 1.0);
    assert_non_null(second->middle);
    assert_int_equal(second->tetrahedron_count, volume->tetrahedron_count);
    assert_nodes_near(second, volume, 0.0);
    ss_mesh_destroy(&second);
    ss_mesh_destroy(&surface);
    ss_mesh_destroy(&volume);
}

TEST(cavities_stay_hollow)
{
    char out[4096];
    if (run("command -v tetgen", out, sizeof out) != 0) {
        print_message("tetgen is not installed: not tested\n");
        skip();
    }
    /* A unit cube in a cube of 3, turned inside out. */
    write_text(
        "hollow.obj", CUBE_V
        "v -1 -1 -1\nv 2 -1 -1\nv -1 2 -1\nv 2 2 -1\nv -1 -1 2\nv 2 -1 2\nv -1 2 2\nv 2 2 2\n"
        "f 4 3 1\nf 2 4 1\nf 8 6 5\nf 7 8 5\nf 6 2 1\nf 5 6 1\nf 8 7 3\nf 4 8 3\nf 7 5 1\n"
        "f 3 7 1\nf 8 4 2\nf 6 8 2\nf 9 11 12\nf 9 12 10\nf 13 14 16\nf 13 16 15\nf 9 10 14\n"
        "f 9 14 13\nf 11 15 16\nf 11 16 12\nf 9 13 15\nf 9 15 11\nf 10 12 16\nf 10 16 14\n");
    run_tool("tetrahedralize hollow.obj h.msh --edge 1");
    ss_mesh *m = load(in_folder("h.msh"), 1.0);
    ss_mesh_report r;
    assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
    assert_near(r.volume, 26.0, 1e-9);
    ss_mesh_destroy(&m);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
