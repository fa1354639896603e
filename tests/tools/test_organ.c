/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-mesh scene: what it chooses, and that what it writes can be felt. */
#include "common/test.h"

#include <math.h>

#include "common/effort.h"
#include "common/tool_fixture.h"

static char out[8192], text[8192];

/* ---- every tissue, body and model ---- */

static const char *const tissues[] = {"brain",  "breast", "fat",    "gelatine", "heart",
                                      "kidney", "liver",  "muscle", "skin"};
enum { TISSUES = sizeof tissues / sizeof *tissues };

/* Shares of Hertz' force that are plausible: networks are scaled to it; on meshes whose edges are
 * about as long as the tool's radius linear tetrahedra are up to three times too stiff. */
static const struct {
    const char *name;
    double low, high;
} models[] = {{"cnn-energy", 0.95, 1.05},
              {"fem-quadratic", 0.5, 1.5},
              {"cnn-chainmail", 0.95, 1.05},
              {"fem", 0.8, 3.0}};
enum { MODELS = sizeof models / sizeof *models };

static double number_after(const char *where, const char *mark)
{
    const char *at = strstr(where, mark);
    if (at == NULL) {
        fail_msg("no '%s' in: %s", mark, where);
        return NAN;
    }
    return strtod(at + strlen(mark), NULL);
}

/* The force that is told, beside Hertz' for what is told of depth, tool and modulus. */
static double told_ratio(void)
{
    const double force = number_after(out, "pressed and held: ");
    const double depth = 1e-3 * number_after(out, " Pa and the ");
    const double radius = 1e-3 * number_after(out, "a ball of ");
    const double modulus = number_after(out, "times Hertz's force for ");
    return force / (4.0 / 3.0 * modulus / (1.0 - 0.45 * 0.45) * sqrt(radius) * depth * sqrt(depth));
}

static void expect_organ(const char *mesh, const char *tissue, int model)
{
    char command[512];
    (void)snprintf(command, sizeof command, TOOL "scene %s --tissue %s --model %s --out organ.yaml",
                   mesh, tissue, models[model].name);
    if (run(command, out, sizeof out) != 0 || strstr(out, " mm: good\n") == NULL) {
        fail_msg("%s: %s", command, out);
    }
    const double ratio = told_ratio();
    if (!(ratio > models[model].low && ratio < models[model].high)) {
        fail_msg("%s: %g of Hertz: %s", command, ratio, out);
    }
    if (run(BIN_DIR "/softsimd organ.yaml --check", text, sizeof text) != 0 ||
        strstr(text, "organ.yaml: good (") == NULL) {
        fail_msg("%s: %s", command, text);
    }
    print_message("%s, %s, %s: %.2f of Hertz\n", mesh, tissue, models[model].name, ratio);
}

TEST_WITH(every_tissue_on_every_body_presses_well_by_every_model, make_folder, remove_folder)
{
    static const char *const bodies[] = {"kidney.vtk", "liver.vtk", "block.msh"};
    run_tool("generate kidney --tetrahedra --points 400 --out kidney.vtk");
    run_tool("generate liver --tetrahedra --points 400 --out liver.vtk");
    run_tool("generate block --tetrahedra --size-mm 80,80,40 --points 250 --out block.msh");
    for (int b = 0; b < 3; ++b) {
        for (int m = 0; m < FULL_IN_RELEASE(MODELS, 1); ++m) {
            for (int t = 0; t < TISSUES; ++t) {
                /* Otherwise each model on one or two bodies, of another tissue each. */
                if (is_long_run() || ((b + m) % 2 == 0 && t == (5 * b + 2 * m + 6) % TISSUES)) {
                    expect_organ(bodies[b], tissues[t], m);
                }
            }
        }
    }
}

/* ---- choices ---- */

/* The unit is the one in which a body is an organ; between two, the one nearer to 12 cm. The liver
 * in decimetres is 2.0 x 1.2 x 0.8, which would do for centimetres too. */
TEST_WITH(the_unit_is_judged_by_size, make_folder, remove_folder)
{
    static const struct {
        const char *body, *unit;
    } cases[] = {{"liver", "dm"}, {"kidney", "mm"}, {"kidney", "m"}, {"kidney", "cm"}};
    char wanted[64];
    for (size_t i = 0; i < FULL_IN_RELEASE(sizeof cases / sizeof *cases, 1); ++i) {
        run_tool("generate %s --points 120 --units %s --out body.obj", cases[i].body,
                 cases[i].unit);
        assert_int_equal(run(TOOL "scene body.obj --tissue liver --out o.yaml", out, sizeof out),
                         0);
        (void)snprintf(wanted, sizeof wanted, ", in %s (judged by size, ", cases[i].unit);
        if (strstr(out, wanted) == NULL) {
            fail_msg("not '%s': %s", wanted, out);
        }
        (void)snprintf(wanted, sizeof wanted, "  units: %s  # ", cases[i].unit);
        read_text("o.yaml", text, sizeof text);
        assert_non_null(strstr(text, wanted));
    }
    assert_int_equal(
        run(TOOL "scene body.obj --tissue liver --units m --out m.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, ", in m (as given: the longest side is "));
    run_tool("generate block --size-mm 1e4,1e4,1e4 --points 120 --out body.obj");
    assert_int_equal(run(TOOL "scene body.obj --tissue liver --out n.yaml", out, sizeof out), 2);
    assert_non_null(strstr(out, "give --units"));
    assert_int_equal(access(in_folder("n.yaml"), F_OK), -1);
}

/* The commands after `mark` in what was printed, run as they stand. */
static void run_told(const char *mark)
{
    char command[1800];
    const char *at = strstr(out, mark);
    if (at == NULL) {
        fail_msg("no '%s' in: %s", mark, out);
        return;
    }
    (void)snprintf(command, sizeof command, "PATH=" BIN_DIR ":$PATH; %.1500s", at + strlen(mark));
    command[strcspn(command, "\n")] = '\0';
    if (run(command, out, sizeof out) != 0) {
        fail_msg("%s: %s", command, out);
    }
}

/* Those that a surface is told to be filled by. */
static void run_filling(void)
{
    char *end = strstr(out, ", then a scene of what that makes");
    if (end == NULL) {
        fail_msg("not told how it is filled: %s", out);
        return;
    }
    *end = '\0';
    run_told(" is a surface: ");
}

/* Was fem-quadratic chosen for `scene`? It is, unless its steps are too slow where this runs. */
static bool is_quadratic(const char *scene)
{
    char chosen[64];
    (void)snprintf(chosen, sizeof chosen, "%s: fem-quadratic, ", scene);
    const char *passed_over = strstr(out, "fem-quadratic (a step of ");
    const bool is_slow = passed_over != NULL && strstr(passed_over, " ms here)") != NULL;
    if ((strstr(out, chosen) != NULL) == is_slow) {
        fail_msg("not fem-quadratic: %s", out);
    }
    return !is_slow;
}

/* Of what comes next the mesh is not doubted any more. */
static void expect_even(const char *verdict)
{
    if (strstr(out, verdict) == NULL) {
        fail_msg("not '%s': %s", verdict, out);
    }
    assert_null(strstr(out, "cuts its corners"));
    assert_null(strstr(out, "is coarse for the tool"));
    assert_non_null(strstr(out, "\nnext: softsimd o.yaml"));
}

/* Corners are not where they are felt where edges are long for the tool, in the mean (a box of
 * eight nodes is refused, a cone of fourteen is not touched) or there alone (a box with one even
 * face). */
TEST_WITH(a_mesh_that_does_not_suit_the_tool_is_to_be_evened_out, make_folder, remove_folder)
{
    SKIP_WHERE_REPEATED();
    static const char box[] = "v 0 0 0\nv 60 0 0\nv 60 40 0\nv 0 40 0\nv 0 0 30\nv 60 0 30\n"
                              "v 60 40 30\nv 0 40 30\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\n"
                              "f 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    write_text("box.obj", box);
    assert_int_equal(
        run(TOOL "scene box.obj --tissue liver --units mm --out o.yaml", out, sizeof out), 2);
    run_told("do not suit a hand's tool: ");
    expect_even(" mm: good\n");
    assert_int_equal(
        run("awk 'BEGIN{print \"v 0 0 60\\nv 0 0 0\"; for (i = 0; i < 12; ++i) printf \"v %.6f "
            "%.6f 0\\n\", 30 * cos(.52359878 * i), 30 * sin(.52359878 * i); for (i = 0; i < 12; "
            "++i) "
            "{a = 3 + i; b = 3 + (i + 1) % 12; print \"f 1\", a, b; print \"f 2\", b, a}}' > "
            "cone.obj; " TOOL "scene cone.obj --tissue liver --units mm --from +z --out o.yaml",
            out, sizeof out),
        0);
    assert_non_null(strstr(out, "cuts its corners off by up to "));
    assert_int_equal(run(BIN_DIR "/softsimd o.yaml --check", text, sizeof text), 1);
    assert_non_null(strstr(text, "cuts its corners off"));
    run_told("next: a mesh that suits the tool: ");
    expect_even(" mm: guarded: the surface slopes there"); /* a tip, still */
    assert_int_equal(
        run("awk 'BEGIN{n = 20; for (i = 0; i <= n; ++i) for (j = 0; j <= n; ++j) print \"v\", 60 "
            "* i "
            "/ n, 60 * j / n, 40; print \"v 0 0 0\\nv 60 0 0\\nv 60 60 0\\nv 0 60 0\"; m = n + 1; "
            "c "
            "= m * m; for (i = 0; i < n; ++i) for (j = 0; j < n; ++j) {a = m * i + j + 1; print "
            "\"f\", a, a + m, a + m + 1; print \"f\", a, a + m + 1, a + 1} for (i = 0; i < n; ++i) "
            "{print \"f\", c + 1, m * (i + 1) + 1, m * i + 1; print \"f\", c + 2, m * n + i + 2, m "
            "* n + "
            "i + 1; print \"f\", c + 3, m * i + m, m * (i + 1) + m; print \"f\", c + 4, i + 1, i + "
            "2} print \"f\", c + 1, c + 2, m * n + 1; print \"f\", c + 2, c + 3, m * m; print "
            "\"f\", "
            "c + 3, c + 4, m; print \"f\", c + 4, c + 1, 1; print \"f\", c + 1, c + 4, c + 3; "
            "print "
            "\"f\", c + 1, c + 3, c + 2}' > lid.obj; " TOOL
            "scene lid.obj --tissue liver --units mm --tool-mm 7 --out o.yaml",
            out, sizeof out),
        0);
    assert_null(strstr(out, "is coarse for the tool"));
    assert_non_null(strstr(out, "cuts its corners off by up to "));
    run_told("next: a mesh that suits the tool: ");
    expect_even(" mm: good\n");
}

/* In a unit that makes no organ of it it is taken, and told. The kidney has 107 to 110 mm. */
TEST_WITH(a_size_that_no_organ_has_is_told, make_folder, remove_folder)
{
    SKIP_WHERE_REPEATED();
    run_tool("generate kidney --points 120 --units mm --out body.obj");
    assert_int_equal(
        run(TOOL "scene body.obj --tissue kidney --units cm --out o.yaml", out, sizeof out), 0);
    const double size = number_after(out, "warning: o.yaml: --units cm makes the mesh's longest "
                                          "side ");
    assert_true(size > 1050.0 && size < 1110.0);
    const double fitting = number_after(out, "; in mm it has ");
    assert_true(fabs(fitting - 0.1 * size) < 0.1);
    assert_non_null(strstr(out, " mm: --units mm\n"));
    assert_int_equal(
        run(TOOL "scene body.obj --tissue kidney --units mm --out o.yaml", out, sizeof out), 0);
    assert_null(strstr(out, "an organ has 2 to 30 cm"));
    run_tool("generate block --size-mm 1e3,1e3,1e3 --points 120 --units m --out body.obj");
    assert_int_equal(
        run(TOOL "scene body.obj --tissue liver --units mm --out n.yaml", out, sizeof out), 2);
    assert_int_equal(
        run(TOOL "scene body.obj --tissue liver --units m --out n.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, "--units m makes the mesh's longest side 1000 mm"));
}

/* What is held: what was asked for is what the scene has, and the server counts the same. */
TEST_WITH(the_held_part_is_chosen_or_as_asked, make_folder, remove_folder)
{
    static const struct {
        const char *option, *says, *checked;
    } cases[] = {
        {"", "    - {plane: {point_m: [", NULL},
        {"--fixed bottom", "    - {group: \"bottom\"}", NULL},
        {"--fixed '{box_m: [[-1, -1, -1], [1, 1, -0.01]]}'", "    - {box_m: [[-1, -1, -1]", NULL},
        {"--from -z", "normal: [0, 0, -1]", NULL},
    };
    run_tool("generate block --tetrahedra --size-mm 80,80,40 --points 120 --out block.msh");
    for (size_t i = 0; i < FULL_IN_RELEASE(sizeof cases / sizeof *cases, 2); ++i) {
        char command[512];
        (void)snprintf(command, sizeof command,
                       TOOL "scene block.msh --tissue liver --model cnn-energy --out o.yaml %s",
                       cases[i].option);
        if (run(command, out, sizeof out) != 0) {
            fail_msg("%s: %s", command, out);
        }
        read_text("o.yaml", text, sizeof text);
        assert_non_null(strstr(text, cases[i].says));
        const int held = (int)number_after(out, "held: ");
        (void)run(BIN_DIR "/softsimd o.yaml --check", text, sizeof text);
        assert_int_equal((int)number_after(text, "o.yaml: fixed: "), held);
        assert_true((held == 0) == (cases[i].checked != NULL));
    }
}

/* A surface gets a model that takes it; asked for another, it is told how to be filled. */
TEST_WITH(a_surface_is_felt_or_told_how_to_be_filled, make_folder, remove_folder)
{
    run_tool("generate kidney --points 250 --out kidney.obj");
    if (run(TOOL "scene kidney.obj --tissue kidney --out k.yaml", out, sizeof out) != 0 ||
        strstr(out, "k.yaml: cnn-energy, 250 nodes of a surface, in mm") == NULL) {
        fail_msg("%s", out);
    }
    assert_non_null(strstr(out, " kidney-filled.msh --units mm"));
    assert_non_null(strstr(out, "cnn-energy has no physical constants: they were scaled to Hertz"));
    run_tool("generate kidney --points 1200 --out kidney.obj"); /* finer than what fills it */
    assert_int_equal(
        run(TOOL "scene kidney.obj --tissue kidney --model fem --out f.yaml", out, sizeof out), 2);
    assert_int_equal(access(in_folder("f.yaml"), F_OK), -1);
    run_filling();
    assert_int_equal(
        run(TOOL "scene kidney-filled.msh --tissue kidney --out f.yaml", out, sizeof out), 0);
    if (is_quadratic("f.yaml")) {
        assert_null(strstr(out, "were scaled to"));
        assert_true(told_ratio() > 0.8 && told_ratio() < 1.2);
    }
}

TEST_WITH(a_picture_is_one, make_folder, remove_folder)
{
    run_tool("generate kidney --points 250 --out kidney.obj");
    const int status =
        run(TOOL "scene kidney.obj --tissue liver --out k.yaml --preview k.png", out, sizeof out);
    if (status == 2 && strstr(out, "gnuplot cannot be started") != NULL) {
        skip();
    }
    assert_int_equal(status, 0);
    read_text("k.png", text, sizeof text);
    assert_memory_equal(text, "\x89PNG\r\n\x1a\n", 8);
}

TEST_WITH(tissues_are_listed_with_their_sources, make_folder, remove_folder)
{
    assert_int_equal(run(TOOL "scene --tissues", out, sizeof out), 0);
    for (int t = 0; t < TISSUES; ++t) {
        char line[32];
        (void)snprintf(line, sizeof line, "\n%s ", tissues[t]);
        const char *at = strstr(out, line);
        assert_non_null(at);
        const char *source = strstr(at, " et al. ");
        assert_true(source != NULL && source < strchr(at + 1, '\n'));
    }
}

TEST_WITH(holes_are_told, make_folder, remove_folder)
{
    run_tool("generate cylinder --radius-m 0.03 --length-m 0.1 --out tube.obj");
    assert_int_equal(
        run(TOOL "scene tube.obj --tissue skin --from +x --out s.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, "tube.obj has holes (48 open edges)"));
    run_tool("generate kidney --points 120 --out kidney.obj");
    assert_int_equal(run(TOOL "scene kidney.obj --tissue kidney --out k.yaml", out, sizeof out), 0);
    assert_null(strstr(out, "has holes ("));
}

/* A model that is planned too slow is pressed as deep as any other before it is told good. */
TEST_WITH(a_slow_surface_is_pressed_as_deep_as_any, make_folder, remove_folder)
{
    SKIP_WHERE_REPEATED();
    run_tool("generate kidney --points 2400 --out kidney.obj");
    assert_int_equal(run(TOOL "scene kidney.obj --tissue kidney --out k.yaml", out, sizeof out), 0);
    const double first = number_after(out, "pressed and held: ");
    const double deepest = number_after(out, "that the surface went; ");
    const char *at = strstr(out, "that the surface went; ");
    assert_true(deepest > first && number_after(at, " N at ") > 7.0);
}

/* The kidney and once more, beside it and above, in one file. */
static void write_two(int aside_mm, int above_mm)
{
    char command[512];
    run_tool("generate kidney --points 120 --out one.obj");
    (void)snprintf(
        command, sizeof command,
        "awk -v d=%d -v h=%d '/^v /{++n; v[n]=$0; print; next} /^f /{f[++m]=$0; print} END{for (i "
        "= 1; i <= n; ++i) {split(v[i], p); print \"v\", p[2] + d, p[3], p[4] + h} for (i = 1; "
        "i <= m; ++i) {split(f[i], p); print \"f\", p[2] + n, p[3] + n, p[4] + n}}' one.obj "
        "> two.obj",
        aside_mm, above_mm);
    assert_int_equal(run(command, out, sizeof out), 0);
}

TEST_WITH(parts_and_crossings_are_told, make_folder, remove_folder)
{
    write_two(150, 0);
    assert_int_equal(run(TOOL "scene two.obj --tissue kidney --out o.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, "warning: o.yaml: two.obj has 2 separate parts"));
    assert_null(strstr(out, " cross others"));
    assert_non_null(strstr(out, "fill it: softsim-mesh "));
    write_two(20, 0);
    assert_int_equal(run(TOOL "scene two.obj --tissue kidney --out o.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, "triangles of two.obj cross others"));
    assert_null(strstr(out, "tetrahedralize"));
    write_two(0, 80); /* the plane has nothing of the upper one */
    assert_int_equal(run(TOOL "scene two.obj --tissue kidney --out o.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, "and each is held at its side away from the hand"));
    assert_non_null(strstr(out, " mm: good\n"));
    assert_int_equal(run(TOOL
                         "scene two.obj --tissue kidney --fixed '{box_m: [[-1, -1, -1], [1, 1, "
                         "0]]}' --out o.yaml",
                         out, sizeof out),
                     2);
    assert_non_null(strstr(out, "of its 2 separate parts each is to be held"));
}

/* Caps of 80 triangles around a node are everyday work of other programs. */
TEST_WITH(a_cylinder_of_80_sides_is_felt, make_folder, remove_folder)
{
    assert_int_equal(run("awk 'BEGIN{n = 80; m = 12; for (k = 0; k <= m; ++k) for (i = 0; i < n; "
                         "++i) printf \"v %g "
                         "%g %g\\n\", 30 * cos(6.2831853 * i / n), 30 * sin(6.2831853 * i / n), 80 "
                         "* k / m; print "
                         "\"v 0 0 0\"; print \"v 0 0 80\"; c = n * (m + 1); for (i = 0; i < n; "
                         "++i) {j = (i + 1) % "
                         "n; print \"f\", c + 1, j + 1, i + 1; print \"f\", c + 2, n * m + i + 1, "
                         "n * m + j + 1; for "
                         "(k = 0; k < m; ++k) {a = n * k; print \"f\", a + i + 1, a + j + 1, a + n "
                         "+ j + 1; print "
                         "\"f\", a + i + 1, a + n + j + 1, a + n + i + 1}}}' > cylinder.obj",
                         out, sizeof out),
                     0);
    assert_int_equal(
        run(TOOL "scene cylinder.obj --tissue kidney --from +x --out c.yaml", out, sizeof out), 0);
    const double ratio = number_after(out, "of indentation, ");
    assert_true(ratio > 0.8 && ratio < 1.2);
    assert_non_null(strstr(out, " mm: good\n"));
}

/* A slender body is to keep its shape: edges that are told are not longer than that allows, and
 * longer ones are refused, or warned of. */
TEST_WITH(a_rod_keeps_its_volume, make_folder, remove_folder)
{
    SKIP_WHERE_REPEATED();
    assert_int_equal(
        run("awk 'BEGIN{n = 24; m = 120; for (k = 0; k <= m; ++k) for (i = 0; i < n; ++i) printf "
            "\"v %g %g %g\\n\", 5 * cos(6.2831853 * i / n), 5 * sin(6.2831853 * i / n), 150 * k / "
            "m; print \"v 0 0 0\"; print \"v 0 0 150\"; c = n * (m + 1); for (i = 0; i < n; ++i) "
            "{j = (i + 1) % n; print \"f\", c + 1, j + 1, i + 1; print \"f\", c + 2, n * m + i + "
            "1, n * m + j + 1; for (k = 0; k < m; ++k) {a = n * k; print \"f\", a + i + 1, a + j + "
            "1, a + n + j + 1; print \"f\", a + i + 1, a + n + j + 1, a + n + i + 1}}}' > rod.obj",
            out, sizeof out),
        0);
    assert_int_equal(run(TOOL "remesh rod.obj r.obj --units mm --edge-mm 9.1", out, sizeof out), 2);
    assert_non_null(strstr(out, "too long for what is thin of it"));
    assert_int_equal(access(in_folder("r.obj"), F_OK), -1);
    /* Two that are wound against each other have no volume to compare. */
    assert_int_equal(
        run("awk '/^v/{print; n++; v[n]=$2 \" \" $3 + 40 \" \" $4} /^f/{f[++m]=$2 + 2906 "
            "\" \" $4 + 2906 \" \" $3 + 2906; print} END{for(i=1;i<=n;++i) print \"v\", "
            "v[i]; for(i=1;i<=m;++i) print \"f\", f[i]}' rod.obj > two.obj; " TOOL
            "remesh two.obj r.obj --units mm --edge-mm 3.6",
            out, sizeof out),
        0);
    assert_int_equal(
        run(TOOL "scene rod.obj --tissue kidney --model fem --out o.yaml", out, sizeof out), 2);
    run_filling();
    const double before = number_after(out, "slivers, volume ");
    const double after = number_after(strstr(out, "rod-coarse.obj: "), "slivers, volume ");
    assert_true(fabs(after - before) < 0.08 * before);
}

/* ---- kinds of bodies ---- */

/* A ball of 80 mm by `slices` from pole to pole and half as many rings; each triangle with nodes of
 * its own (a soup), or with a hollow of `hollow` mm inside. */
static void write_ball(int slices, bool is_soup, double hollow)
{
    FILE *file = open_file("ball.obj");
    const int rings = slices / 2, skins = hollow > 0.0 ? 2 : 1;
    int node = 0;
    for (int n = 0; n < skins * 2 * slices * rings; ++n) {
        const int skin = n / (2 * slices * rings), half = n % 2, i = n / 2 % slices;
        const int j = n / (2 * slices) % rings;
        const int corner[2][3][2] = {{{i, j}, {i, j + 1}, {i + 1, j + 1}},
                                     {{i, j}, {i + 1, j + 1}, {i + 1, j}}};
        if (j == (half == 0 ? rings - 1 : 0)) {
            continue; /* flat at a pole */
        }
        for (int k = 0; k < 3; ++k) {
            const double polar = M_PI * corner[half][k][1] / rings;
            const double around = 2.0 * M_PI * (corner[half][k][0] % slices) / slices;
            const double radius = skin == 0 ? 40.0 : hollow;
            const bool is_pole = corner[half][k][1] % rings == 0;
            (void)fprintf(file, "v %.9g %.9g %.9g\n",
                          is_pole ? 0.0 : radius * sin(polar) * cos(around),
                          is_pole ? 0.0 : radius * sin(polar) * sin(around), radius * cos(polar));
        }
        (void)fprintf(file, "f %d %d %d\n", node + 1, node + (skin == 0 ? 2 : 3),
                      node + (skin == 0 ? 3 : 2));
        node += 3;
    }
    assert_int_equal(fclose(file), 0);
    if (!is_soup) {
        run_tool("convert ball.obj ball.obj --repair --overwrite");
    }
}

/* Triangles that share no node are stitched; within a skin another is a hollow of the same body. */
TEST_WITH(a_soup_and_a_hollow_body_are_one_body, make_folder, remove_folder)
{
    for (int k = 0; k < 2; ++k) {
        write_ball(24, k == 0, k == 0 ? 0.0 : 20.0);
        assert_int_equal(run(TOOL "scene ball.obj --tissue liver --out o.yaml", out, sizeof out),
                         0);
        assert_non_null(strstr(out, k == 0 ? " 266 nodes" : " 532 nodes"));
        assert_null(strstr(out, "separate parts"));
        assert_non_null(strstr(out, " mm: good\n"));
    }
}

/* 200 triangles at a pole are more than a model takes: the command that is told mends it, whatever
 * the file's name. */
TEST_WITH(a_fan_is_refused_with_what_mends_it, make_folder, remove_folder)
{
    write_ball(200, false, 0.0);
    assert_int_equal(run("mv ball.obj \"It's a ball.obj\"; " TOOL
                         "scene \"It's a ball.obj\" --tissue liver --out o.yaml",
                         out, sizeof out),
                     2);
    assert_non_null(strstr(out, "has 200 triangles around it"));
    assert_int_equal(access(in_folder("o.yaml"), F_OK), -1);
    run_told("do not suit a hand's tool: ");
    expect_even(" mm: good\n");
}

/* What is told at rest is at rest: a brain's network relaxes for seconds. As softsim-run feels it.
 */
TEST_WITH(a_press_is_held_until_it_rests, make_folder, remove_folder)
{
    run_tool("generate liver --points 500 --out l.obj");
    assert_int_equal(run(TOOL "scene l.obj --tissue brain --out o.yaml", out, sizeof out), 0);
    const double told = number_after(out, "pressed and held: ");
    const double depth = number_after(strstr(out, "pressed and held: "), " N at ");
    const char *deepest = strstr(out, "that the surface went; ");
    assert_non_null(deepest);
    const double power =
        log(number_after(deepest, "went; ") / told) / log(number_after(deepest, " N at ") / depth);
    const char *touch = strstr(out, " touches at ");
    double x[3] = {0.0};
    assert_non_null(touch);
    assert_int_equal(sscanf(touch, " touches at %lf,%lf,%lf", &x[0], &x[1], &x[2]), 3);
    char path[400];
    (void)snprintf(path, sizeof path,
                   "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,%g,%g,%g,1,0,0,0,0\n"
                   "0.5,0,%g,%g,%g,1,0,0,0,0\n15,0,%g,%g,%g,1,0,0,0,0\n",
                   x[0], x[1], x[2] + 0.003, x[0], x[1], x[2] - 1e-3 * depth, x[0], x[1],
                   x[2] - 1e-3 * depth);
    write_text("p.csv", path);
    assert_int_equal(run(BIN_DIR
                         "/softsim-run o.yaml --poses p.csv --csv f.csv 2>/dev/null; tail -n 1 "
                         "f.csv",
                         out, sizeof out),
                     0);
    /* It comes to touch a little below the place that is told: between the two forces told. */
    double felt = 0.0, way = 0.0;
    const char *row = strstr(out, "15000,");
    assert_non_null(row);
    assert_int_equal(sscanf(row, "%*d,%*f,%*d,%*f,%*f,%lf,%*f,%*f,%*[^,],%lf", &felt, &way), 2);
    const double wanted = told * pow(1e3 * way / depth, power);
    print_message("told %g N, felt after 15 s %g N, at its depth %g N told\n", told, felt, wanted);
    assert_true(fabs(felt - wanted) < 0.03 * wanted);
}

/* Linear tetrahedra that press far harder than Hertz give way, where the quadratic ones are not in
 * time; the coarser mesh that is told is for them. A limit that a model lowered is not the next
 * one's. */
TEST_WITH(a_stiff_model_gives_way_and_a_coarser_mesh_is_told, make_folder, remove_folder)
{
    SKIP_WHERE_REPEATED();
    run_tool("generate kidney --tetrahedra --points 1000 --out k.msh");
    assert_int_equal(
        run(TOOL "scene k.msh --tissue kidney --for accuracy --out o.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, "o.yaml: cnn-energy"));
    assert_non_null(strstr(out, "times Hertz's force)"));
    assert_null(strstr(out, "(the force limit)"));
    run_told("for models with physical constants, a coarser mesh: ");
    assert_int_equal(run(TOOL "scene k-filled.msh --units mm --tissue kidney --for accuracy --out "
                              "f.yaml",
                         out, sizeof out),
                     0);
    if (is_quadratic("f.yaml")) {
        const double ratio = number_after(out, "of indentation, ");
        assert_true(ratio > 0.7 && ratio < 1.4);
    }
}

/* Of a stiff model that presses well and none at all the stiff one is kept: the network refuses a
 * part that is not held. What gives way as a whole is not good. */
TEST_WITH(a_stiff_model_is_better_than_none, make_folder, remove_folder)
{
    SKIP_WHERE_REPEATED();
    static const char twice[] =
        "awk '/^POINTS/{n=$2; print \"POINTS\", 2*n, $3; next} /^CELLS/{c=$2; for(i=1;i<=n;++i) "
        "print "
        "p[i]; print \"CELLS\", 2*c, 2*$3; s=2; next} /^CELL_TYPES/{for(i=1;i<=c;++i) print q[i]; "
        "print \"CELL_TYPES\", 2*c; for(i=1;i<=2*c;++i) print 10; exit} n && !s {k++; print; "
        "p[k]=(f*$1+a) \" \" f*$2 \" \" f*$3-10; next} s==2 {m++; print; q[m]=$1; "
        "for(j=2;j<=NF;++j) "
        "q[m]=q[m] \" \" ($j+n); next} {print}' ";
    static const char *const kinds[] = {"f=.6 a=60", "f=1 a=80"};
    char command[1200];
    run_tool("generate ellipsoid --tetrahedra --size-mm 60,40,40 --points 300 --out one.vtk");
    for (int k = 0; k < 2; ++k) {
        (void)snprintf(command, sizeof command,
                       "%s %s one.vtk > two.vtk; " TOOL
                       "scene two.vtk --units mm --tissue heart --out o.yaml --fixed '{box_m: "
                       "[[-0.06, -0.06, -0.06], [0.04, 0.06, -0.01]]}'",
                       twice, kinds[k]);
        assert_int_equal(run(command, out, sizeof out), 0);
        assert_non_null(strstr(out, "o.yaml: fem, "));
        assert_non_null(
            strstr(out, k == 0 ? " mm: good\n" : " mm: guarded: what is pressed gives"));
    }
}

/* A force that is the limit's is told, and is not good where it is held: a kidney of 200 nodes
 * sinks in, so that the limit is lowered. */
TEST_WITH(a_press_that_ends_at_the_limit_is_told, make_folder, remove_folder)
{
    run_tool("generate kidney --tetrahedra --points 200 --out k.msh");
    assert_int_equal(run(TOOL "scene k.msh --tissue heart --tool-mm 6 --model fem --out o.yaml; "
                              "cat o.yaml",
                         out, sizeof out),
                     0);
    const double limit = number_after(out, "max_force_n: ");
    assert_true(fabs(number_after(out, "that the surface went; ") - limit) < 0.01 * limit);
    assert_non_null(strstr(out, " N (the force limit) at "));
}

/* Only fem-quadratic takes second-order tetrahedra, whatever the scene is for. */
TEST_WITH(second_order_is_quadratic, make_folder, remove_folder)
{
    SKIP_WHERE_REPEATED();
    static const char *const purposes[] = {"feel", "accuracy", "speed"};
    char command[256];
    run_tool("generate kidney --tetrahedra --order 2 --points 400 --out q.vtk");
    for (int k = 0; k < 3; ++k) {
        (void)snprintf(command, sizeof command,
                       TOOL "scene q.vtk --tissue kidney --for %s --out o.yaml", purposes[k]);
        assert_int_equal(run(command, out, sizeof out), 0);
        assert_non_null(strstr(out, "o.yaml: fem-quadratic, "));
    }
    assert_int_equal(
        run(TOOL "scene q.vtk --tissue kidney --model fem --out n.yaml", out, sizeof out), 2);
    assert_non_null(strstr(out, "--order 1"));
}

/* A body of 25 is one in centimetres and in millimetres. */
TEST_WITH(two_units_that_would_do_are_told, make_folder, remove_folder)
{
    run_tool("generate block --size-mm 25,13,10 --points 300 --out block.obj");
    assert_int_equal(run(TOOL "scene block.obj --tissue kidney --out o.yaml", out, sizeof out), 0);
    assert_non_null(strstr(out, "warning: o.yaml: the mesh's unit was judged: in cm "));
    assert_non_null(strstr(out, "mm would do too"));
    assert_int_equal(
        run(TOOL "scene block.obj --tissue kidney --units mm --out o.yaml", out, sizeof out), 0);
    assert_null(strstr(out, "would do too"));
}

/* A tool that finds nothing to press where it is sent is not called good: 8 nodes, a corner. */
TEST_WITH(what_is_not_touched_is_not_called_good, make_folder, remove_folder)
{
    (void)write_text("box.obj",
                     "v 0 0 0\nv 90 0 0\nv 90 70 0\nv 0 70 0\nv 0 0 50\nv 90 0 50\nv 90 70 50\n"
                     "v 0 70 50\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 "
                     "8\n");
    assert_int_equal(
        run(TOOL "scene box.obj --tissue kidney --tool-mm 40 --out b.yaml", out, sizeof out), 0);
    assert_null(strstr(out, " mm: good\n"));
    assert_non_null(strstr(out, "degraded: the tool did not touch"));
}

/* What draws the hand in is not called good, as the rim of a hole in a block's lid, through which
 * the tool goes; nor what pushes it aside, as the rim of a kidney's wall. */
TEST_WITH(a_press_on_a_rim_is_not_called_good, make_folder, remove_folder)
{
    SKIP_WHERE_REPEATED();
    run_tool("generate block --size-mm 60,60,30 --tetrahedra --points 1500 --out block.msh");
    run_tool("convert block.msh block.obj");
    assert_int_equal(
        run("awk '/^v /{x[++n]=$2; y[n]=$3; z[n]=$4; print; next} /^f /{u=(x[$2]+x[$3]+x[$4])/3; "
            "v=(y[$2]+y[$3]+y[$4])/3; if (z[$2]+z[$3]+z[$4] < 44.9 || u*u+v*v > 36) print}' "
            "block.obj > open.obj; " TOOL "scene open.obj --tissue kidney --units mm --out o.yaml",
            out, sizeof out),
        0);
    assert_true(number_after(out, "that the surface went; ") < 0.0);
    assert_non_null(strstr(out, "guarded: the force at rest draws the tool in: it slips over an "
                                "edge or through a hole"));
    run_tool("generate kidney --points 1100 --out kidney.obj");
    assert_int_equal(
        run("awk '/^v /{z[++n]=$4; if ($4 > top) top=$4; print; next} /^f /{if (z[$2] < top - 14 "
            "|| z[$3] < top - 14 || z[$4] < top - 14) print}' kidney.obj > open.obj; " TOOL
            "scene open.obj --tissue kidney --out o.yaml",
            out, sizeof out),
        0);
    assert_non_null(strstr(out, "guarded: the surface slopes there and pushes the tool aside"));
}

/* A group's name goes into the scene's quotes; the server counts the same nodes. */
TEST_WITH(names_of_groups_are_quoted, make_folder, remove_folder)
{
    run_tool("generate block --tetrahedra --size-mm 80,80,40 --points 120 --out block.msh");
    assert_int_equal(
        run("sed 's/\"bottom\"/\"a\\\\b: #{c}\"/' block.msh > odd.msh", out, sizeof out), 0);
    assert_int_equal(run(TOOL "scene odd.msh --tissue liver --model cnn-energy --out o.yaml "
                              "--fixed 'a\\b: #{c}'",
                         out, sizeof out),
                     0);
    const int held = (int)number_after(out, "held: ");
    assert_true(held > 0);
    (void)run(BIN_DIR "/softsimd o.yaml --check", text, sizeof text);
    assert_int_equal((int)number_after(text, "o.yaml: fixed: "), held);
}

/* Stopped when its draft is there: the draft goes. */
TEST_WITH(a_signal_leaves_nothing_behind, make_folder, remove_folder)
{
    run_tool("generate liver --tetrahedra --points 300 --out liver.msh");
    assert_int_equal(run("{ " TOOL "scene liver.msh --tissue liver --out l.yaml & pid=$!; "
                         "until ls l.yaml.*.tmp 2>/dev/null || ! kill -0 $pid; do :; done; "
                         "kill -TERM $pid; wait $pid; echo status $?; ls; }",
                         out, sizeof out),
                     0);
    assert_non_null(strstr(out, "status 143\n"));
    const char *listed = strstr(out, "status 143\n");
    assert_true(strstr(listed, ".tmp") == NULL && strstr(listed, "l.yaml") == NULL);
}

/* ---- hostile arguments ---- */

TEST_WITH(bad_arguments_are_named_and_write_nothing, make_folder, remove_folder)
{
    static const tool_row rows[] = {
        {"scene", 2, "MESH is missing"},
        {"scene k.obj", 2, "--out is missing"},
        {"scene k.obj --out o.yaml", 2, "--tissue is missing: give one of brain, breast"},
        {"scene k.obj --tissue stone --out o.yaml", 2, "--tissue: 'stone' is not known"},
        {"scene k.obj --tissue liver --model stone --out o.yaml", 2, "'stone' is not built in"},
        {"scene k.obj --tissue liver --for fun --out o.yaml", 2, "--for"},
        {"scene k.obj --tissue liver --units furlong --out o.yaml", 2, "--units"},
        {"scene k.obj --tissue liver --tool-mm 0 --out o.yaml", 2, "--tool-mm"},
        {"scene k.obj --tissue liver --tool-mm nan --out o.yaml", 2, "--tool-mm"},
        {"scene k.obj --tissue liver --tool-mm 500 --out o.yaml", 2, "wider than the organ"},
        {"scene k.obj --tissue liver --for accuracy --out o.yaml", 2, "accuracy needs tetrahedra"},
        {"scene k.obj --tissue liver --out k.obj", 2, "--out"},
        {"scene k.obj --tissue liver --out o.yaml --preview o.yaml", 2, "--preview"},
        {"scene k.obj --tissue liver --out /dev/null", 2, "--out: '/dev/null' is no file"},
        {"scene k.obj --tissue liver --out nowhere/o.yaml", 2, "the folder of 'nowhere/o.yaml'"},
        {"scene missing.obj --tissue liver --out o.yaml", 2, "missing.obj"},
        {"scene k.obj --tissue liver --out o.yaml --fixed '{box_m: [['", 2, "o.yaml:"},
        {"scene k.obj --tissue liver --out o.yaml --fixed '{group: none}'", 2, "no group 'none'"},
        {"scene k.obj --tissue liver --out o.yaml --fixed skin", 2, "--fixed: 'skin' is "},
        {"scene k.obj --tissue liver --out o.yaml --fixed none", 2, "--fixed: 'none' is no group"},
        {"scene k.obj --tissue liver --out o.yaml --fixed \"{nodes: [$(seq -s, 0 3000)]}\"", 2,
         "--fixed: longer than 2047"},
        {"scene k.obj --tissue liver --out o.yaml --fixed \"$(printf '{a: 1}\\rb: 2')\"", 2,
         "--fixed: '{a: 1}?b: 2' is no group"},
        {"scene k.obj --tissue liver --model hybrid --out o.yaml", 2, "needs tetrahedra"},
        {"scene k.obj --tissue liver --model mass-spring --out o.yaml", 2, "a scene by hand"},
        {"scene \"$(printf 'k\\377.obj')\" --tissue liver --out o.yaml", 2, "is no UTF-8"},
        {"scene k.obj --tissue liver --out o.yaml --fixed '{plane: {point_m: [0, 0, 1], normal: "
         "[0, 0, "
         "1]}}'",
         2, "nothing to press"},
        {"scene k.obj --tissue liver --out o.yaml --fixed '{sphere: {center_m: [9, 9, 9], "
         "radius_m: "
         "1}}'",
         2, "takes no node"},
        {"scene k.obj --tissue liver --units m --out o.yaml", 2,
         "--units: in m its longest side has "},
        {"scene k.obj --tissue liver --tool-mm 5 --out o.yaml --fixed \"$(printf '{a: "
         "\\n')\"",
         2, "o.yaml:"},
    };
    run_tool("generate kidney --points 100 --out k.obj");
    assert_int_equal(run("cp k.obj \"$(printf 'k\\377.obj')\"", out, sizeof out), 0);
    expect_answers(rows, sizeof rows / sizeof *rows);
    assert_int_equal(access(in_folder("o.yaml"), F_OK), -1);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
