/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Surfaces as programs write them, through softsim-import: what holds a whole body is read whole,
 * and what would be read in part is refused, with what to do. The body is the tetrahedron of the
 * origin and the three unit points.
 */
#include "common/test.h"

#include <stdio.h>
#include <string.h>

#include "common/tool_fixture.h"

typedef struct import_case {
    const char *name, *text;
    int bodies;       /* 0: it is refused */
    const char *says; /* then */
} import_case;

/* NULL, and why in `error`, when it is refused. */
static ss_mesh *try_load(const char *name, const void *data, size_t size, softsim_error *error)
{
    ss_mesh *mesh = NULL;
    *error = (softsim_error){0};
    const softsim_status status =
        ss_mesh_load(write_bytes(name, data, size), 1.0, importer, &mesh, error);
    assert_true((status == SOFTSIM_OK) == (mesh != NULL));
    return mesh;
}

static bool is_as_expected(const import_case *c, const void *data, size_t size)
{
    softsim_error error;
    ss_mesh_report r = {0};
    ss_mesh *mesh = try_load(c->name, data, size, &error);
    bool is_right = c->bodies == 0 && error.fault_count == 1 && strstr(error.text, c->says) != NULL;
    if (mesh != NULL) {
        (void)ss_mesh_check(mesh, &r);
        is_right = mesh->triangle_count == 4 * c->bodies && mesh->node_count == 4 * c->bodies &&
                   mesh->is_closed && fabs(r.volume - c->bodies / 6.0) < 1e-6;
    }
    print_message("%-5s %-20s %d triangles, volume %g %s\n", is_right ? "" : "WRONG", c->name,
                  mesh != NULL ? mesh->triangle_count : 0, r.volume, error.text);
    ss_mesh_destroy(&mesh);
    return is_right;
}

static int count_wrong(const import_case *c, int32_t count)
{
    int wrong = 0;
    for (int32_t i = 0; i < count; ++i) {
        wrong += !is_as_expected(&c[i], c[i].text, strlen(c[i].text));
    }
    return wrong;
}

/* ---- STL ---- */

#define FACET(a, b, c, end)                                                                        \
    "facet normal 0 0 0 outer loop vertex " a " vertex " b " vertex " c " endloop endfacet" end
#define FOUR(o, x, y, z, end)                                                                      \
    FACET(o, y, x, end) FACET(o, x, z, end) FACET(o, z, y, end) FACET(x, y, z, end)
#define BODY  FOUR("0 0 0", "1 0 0", "0 1 0", "0 0 1", "\n")
#define OTHER FOUR("5 0 0", "6 0 0", "5 1 0", "5 0 1", "\n")
#define LINE  FOUR("0 0 0", "1 0 0", "0 1 0", "0 0 1", " ")
#define APART                                                                                      \
    "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nend loop\nend "     \
    "facet\n"

TEST(text_stl_is_read_whole_or_refused)
{
    static const import_case cases[] = {
        {"end-solid.stl", "solid a\n" BODY "end solid a\n", 1, NULL},
        {"end-facet.stl",
         "solid a\n" APART FACET("0 0 0", "1 0 0", "0 0 1", "\n")
             FACET("0 0 0", "0 0 1", "0 1 0", "\n")
                 FACET("1 0 0", "0 1 0", "0 0 1", "\n") "end solid a\n",
         1, NULL},
        {"one-line.stl", "solid a " LINE "endsolid a", 1, NULL},
        {"one-line-end.stl", "solid a " LINE "end solid", 1, NULL},
        {"comment-behind.stl", "solid a\n" BODY "endsolid a\n# made solid by me\n", 1, NULL},
        {"colour-behind.stl", "solid a\n" BODY "endsolid a\ncolor solid 3\n", 1, NULL},
        {"vertex-name.stl", "solid my vertex facet\n" BODY "endsolid my vertex facet\n", 1, NULL},
        {"two.stl", "solid a\n" BODY "endsolid a\n\nsolid b\n" OTHER "endsolid b\n", 2, NULL},
        {"two-end.stl", "solid a\n" BODY "end solid a\nsolid b\n" OTHER "end solid b\n", 2, NULL},
        {"two-open.stl", "solid a\n" BODY "solid b\n" OTHER "endsolid b\n", 2, NULL},
        {"returns.stl", "solid a\r\n" BODY "endsolid a\rsolid b\r\n" OTHER "endsolid b\r", 2, NULL},
        /* Cut off. */
        {"cut-end.stl", "solid a\n" BODY "end soli", 0, ":6: it is cut off: no endsolid after 4"},
        {"cut-line.stl", "solid a " LINE, 0, ":1: it is cut off: no endsolid after 4"},
        {"cut-second.stl", "solid a\n" BODY "end solid a\n solid b\n", 0, "no endsolid after 4"},
        {"cut-facet.stl", "solid a " LINE "facet normal 0 0 0 outer", 0, "within a triangle"},
        {"cut-third.stl", "solid a\n" BODY "end solid a\n" FACET("0 0 0", "1 0 0", "0 1 0", ""), 0,
         "no endsolid after 5"},
        /* assimp would leave out triangles. */
        {"comment.stl", "solid a\n" BODY "endsolid a\n# b\nsolid b\n" OTHER "endsolid b\n", 0,
         ":6: what is behind this endsolid is not read, and 4 triangles are there: "},
        {"headless.stl", "solid a\n" BODY "endsolid a\n" OTHER "endsolid\n", 0, "4 triangles are"},
        {"two-in-line.stl", "solid a " LINE "endsolid a solid b " LINE "endsolid b", 0,
         ":1: what is behind this endsolid is not read, and 4 triangles are there: "},
        {"nameless-line.stl", "solid " LINE "endsolid", 0,
         "facet normal, 9 vertex and 4 endfacet do not make triangles: "},
        {"quad.stl",
         "solid a\n" BODY FACET("0 0 0", "1 0 0", "1 1 0 vertex 0 1 0", "\n") "endsolid a\n", 0,
         "5 facet normal, 16 vertex and 5 endfacet do not make triangles: "},
    };
    int wrong = count_wrong(cases, COUNT(cases));
    static const char padded[] = "solid a\n" BODY "endsolid a\n\0\0\0";
    const import_case zeros = {.name = "zeros.stl", .bodies = 1};
    wrong += !is_as_expected(&zeros, padded, sizeof padded);
    assert_int_equal(wrong, 0);
}

/* ---- PLY ---- */

#define VERTEX "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
#define FACE   "element face 4\nproperty list uchar int vertex_indices\n"
#define CAMERA "element camera 1\nproperty float view_px\nproperty float view_py\n"
#define HEAD   "ply\nformat ascii 1.0\n"
#define POINTS "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
#define FACES  "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
#define PLY    HEAD VERTEX FACE "end_header\n"

TEST(text_ply_is_read_line_by_line)
{
    static const import_case cases[] = {
        {"plain.ply", PLY POINTS FACES, 1, NULL},
        {"more.ply", PLY POINTS "3 0 2 1 255 0 0\n3 0 1 3 9 9\n3 0 3 2 7\n3 1 2 3 255 0 0\n", 1,
         NULL},
        {"behind.ply", PLY POINTS FACES "\n1 2 3\nso it ends\n", 1, NULL},
        {"blank.ply", PLY "\n\n" POINTS "\n \t\n\n" FACES "\n\n", 1, NULL},
        {"returns.ply",
         "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float "
         "y\r\nproperty float z\r\nelement face 4\r\nproperty list uchar int "
         "vertex_indices\r\nend_header\r\n\r\n0 0 0\r\n\r\n1 0 0\r\n0 1 0\r\n0 0 1\r\n\r\n3 0 2 "
         "1\r\n3 0 1 3\r\n3 0 3 2\r\n3 1 2 3\r\n",
         1, NULL},
        {"feed.ply", PLY POINTS "\f" FACES, 1, NULL},
        /* assimp keeps what the row before has more than the last. */
        {"no-end.ply", PLY POINTS "3 0 2 1\n3 0 1 3\n3 1 2 03\n3 0 3 2", 1, NULL},
        /* Elements that assimp has no place for. */
        {"camera-first.ply", HEAD CAMERA VERTEX FACE "end_header\n7 8\n" POINTS FACES, 1, NULL},
        {"camera-within.ply", HEAD VERTEX CAMERA FACE "end_header\n" POINTS "7 8\n" FACES, 1, NULL},
        {"camera-last.ply", HEAD VERTEX FACE CAMERA "end_header\n" POINTS FACES "7 8\n", 1, NULL},
        {"no-property.ply", HEAD VERTEX "element foo 3\n" FACE "end_header\n" POINTS FACES, 1,
         NULL},
        {"old.ply",
         "ply\rformat ascii 1.0\relement vertex 4\rproperty float x\rproperty float y\rproperty "
         "float z\relement face 4\rproperty list uchar int vertex_indices\rend_header\r0 0 0\r1 0 "
         "0\r0 1 0\r0 0 1\r3 0 2 1\r3 0 1 3\r3 0 3 2\r3 1 2 3",
         1, NULL},
        /* Cut off, or not what the header says. */
        {"cut-head.ply", HEAD VERTEX "element fa", 0,
         "it is cut off: its header has no line end_h"},
        {"cut-type.ply", "ply\nformat asc", 0, "it is cut off: its header has no line end_header"},
        {"cut-end.ply", HEAD VERTEX FACE "end_header", 0, "it is cut off: its header has no line "},
        {"cut.ply", PLY POINTS "3 0 2 1 255 0 0\n3 0 1 3 255 0 0\n3 0 3 2 255 0 0\n", 0,
         "it is cut off: its header says 4 of element face, and 3 are whole: "},
        {"cut-row.ply", PLY POINTS "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2\n \n", 0,
         "it is cut off: its header says 4 of element face, and 3 are whole: "},
        {"cut-camera.ply", HEAD VERTEX FACE CAMERA "end_header\n" POINTS FACES "7\n", 0,
         "it is cut off: its header says 1 of element camera, and 0 are whole: "},
        {"cut-blank.ply", HEAD "\n" VERTEX FACE "end_header\n" POINTS "3 0 2 1\n3 0 1 3\n", 0,
         "it is cut off: its header says 4 of element face, and 2 are whole: "},
        {"cut-tab.ply",
         " PLY \nformat ascii 1.0\n" VERTEX " element\tface 4\nproperty list uchar int "
         "vertex_indices\nend_header\n" POINTS "3 0 2 1\n3 0 1 3\n",
         0, "it is cut off: its header says 4 of element face, and 2 are whole: "},
        {"unknown.ply", HEAD VERTEX "colour red\n" FACE "end_header\n" POINTS FACES, 0,
         "unknown.ply:7: 'colour red' is no line of a header that is known here"},
        {"no-corner.ply", PLY POINTS "3 0 2 1\n0\n3 0 3 2\n3 1 2 3\n", 0,
         "no-corner.ply:15: fewer numbers than its header says of element face: "},
        {"short.ply", HEAD VERTEX "property float q\n" FACE "end_header\n" POINTS FACES, 0,
         "short.ply:11: fewer numbers than its header says of element vertex: "},
        {"short-face.ply", PLY POINTS "\n\n3 0 2 1\n3 0 1\n3 0 3 2\n3 1 2 3\n", 0,
         "short-face.ply:17: fewer numbers than its header says of element face: "},
        {"one-line.ply", PLY "0 0 0 1 0 0 0 1 0 0 0 1\n3 0 2 1 3 0 1 3 3 0 3 2 3 1 2 3\n", 0,
         "its header says 4 of element vertex, and 2 are whole: "},
    };
    assert_int_equal(count_wrong(cases, COUNT(cases)), 0);
}

static size_t put(char *out, size_t at, const void *data, size_t size)
{
    memcpy(out + at, data, size);
    return at + size;
}

/* Little-endian, as this host. */
TEST(binary_ply_may_hold_elements_that_assimp_has_no_place_for)
{
    static const float x[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const int32_t node[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    static const char head[] = "ply\nformat binary_little_endian 1.0\n" CAMERA VERTEX
                               "element view 0\nproperty int a\n" FACE "end_header\n";
    char bytes[1024];
    size_t size = put(bytes, 0, head, sizeof head - 1);
    size = put(bytes, size, x[2], 8);
    size = put(bytes, size, x, sizeof x);
    for (int t = 0; t < 4; ++t) {
        size = put(bytes, size, "\3", 1);
        size = put(bytes, size, node[t], sizeof node[t]);
    }
    const import_case whole = {.name = "camera.ply", .bodies = 1};
    const import_case cut = {.name = "cut.ply", .says = "4 of element face, and 3 are whole: "};
    assert_true(is_as_expected(&whole, bytes, size));
    assert_true(is_as_expected(&cut, bytes, size - 1));
}

/* A count of a signed type that is below zero is none: not 255 corners. */
TEST(binary_ply_has_no_list_of_less_than_nothing)
{
    static const char head[] = "ply\nformat binary_little_endian 1.0\n" VERTEX
                               "element face 1\nproperty list char uchar vertex_indices\n"
                               "end_header\n";
    static const import_case below = {.name = "below.ply", .says = "1 of element face, and 0 are"};
    char bytes[1024] = {0};
    size_t size = put(bytes, 0, head, sizeof head - 1) + 4 * 12;
    size = put(bytes, size, "\377", 1) + 300;
    assert_true(is_as_expected(&below, bytes, size));
}

/* ---- OBJ ---- */

/* -0.1 with `digits` zeros behind it is -0.1, and the numbers behind it keep their places. */
TEST(obj_numbers_may_have_any_number_of_digits)
{
    static const int digits[] = {1, 58, 59, 60, 61, 62, 63, 64, 100, 5000};
    static char text[1 << 16];
    for (int32_t i = 0; i < COUNT(digits); ++i) {
        const int n = digits[i];
        const int size =
            snprintf(text, sizeof text,
                     "v -0.1%0*d 0.3%0*d 0.25%0*d # one\nv %0*d 0 0\nv 0 1 0\nv 0 0 1\n"
                     "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n",
                     n, 0, n, 0, n, 0, n, 1);
        softsim_error error;
        ss_mesh *mesh = try_load("digits.obj", text, (size_t)size, &error);
        if (mesh == NULL) {
            fail_msg("%d digits: %s", n, error.text);
        }
        assert_int_equal(mesh->node_count, 4);
        const double expected[2][3] = {{-0.1, 0.3, 0.25}, {1.0, 0.0, 0.0}};
        for (int k = 0; k < 6; ++k) {
            assert_near(mesh->position[k / 3][k % 3], expected[k / 3][k % 3], 0.0);
        }
        ss_mesh_destroy(&mesh);
    }
}

TEST(obj_lines_that_cannot_be_read_are_told_with_their_place)
{
    static const import_case cases[] = {
        {"word.obj", "v 0 0 0\n  v 1\t0.5x 0\n", 0,
         "word.obj:2: column 7: '0.5x' is not a number: correct it"},
        {"comma.obj", "v 0,5 0 0\n", 0, "comma.obj:1: column 3: '0,5' is not a number: correct it"},
        {"long-word.obj",
         "v 0 0 0.0000000000000000000000000000000000000000000000000000000000000000000000-1\n", 0,
         "long-word.obj:1: column 7: '0.000000000000000000' is not a number: correct it"},
        {"two.obj", "v 1 2\n", 0,
         "two.obj:1: a vertex has three numbers, x y z, then a weight or a colour; this has 2: "},
        {"five.obj", "v 1 2 3 4 5\n", 0, "; this has 5: correct it"},
        {"eight.obj", "v 1 2 3 4 5 6 7 8\n", 0, "; this has 8: correct it"},
        {"cut.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1/1  2/2 ", 0,
         "cut.obj:5: a face needs three corners or more: "},
        {"far.obj", "v 1 2 1e400\n", 0, "far.obj:1: the position of this vertex is not finite"},
    };
    assert_int_equal(count_wrong(cases, COUNT(cases)), 0);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
