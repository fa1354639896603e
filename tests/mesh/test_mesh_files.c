/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Mesh files: through softsim-import, to disk and back, and what softsim-mesh makes and says. */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common/effort.h"
#include "common/tool_fixture.h"
#include "mesh/import.h"
#include "mesh/mesh.h"
#include "rt/random.h"
#include "rt/vec.h"

static void expect_cube(const char *path, int32_t nodes)
{
    ss_mesh *mesh = load(path, 1.0);
    ss_mesh_report r;
    softsim_error error = {0};
    (void)ss_mesh_check(mesh, &r);
    assert_int_equal(mesh->node_count, nodes);
    assert_int_equal(mesh->triangle_count, 12);
    assert_true(mesh->is_closed);
    assert_near(r.volume, 1.0, 1e-6);
    if (ss_mesh_accept(mesh, path, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    ss_mesh_destroy(&mesh);
}

/* ---- formats ---- */

#define CUBE_V "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"

TEST(obj_of_quads_with_normals_comments_and_materials_is_one_closed_cube)
{
    expect_cube(
        write_text("cube.obj",
                   "\xEF\xBB\xBF# a cube\nmtllib none.mtl\no cube\n"
                   "v 0 0 0 # first\nv 1 0 0\nv 0 1 0\nv 1 1 0 1.0\n"
                   "  v 0 0 1 .1 .2 .3\r\nv\t1 0 1\nv 0 1 1\nv 2 2 2 2\n"
                   "vt 0 0\nvt 1 1\nvn 0 0 -1\nvn 1 0 0\n"
                   "usemtl red\nf 1/1/1 3/2/1 4/1/1 2/2/1\nf 5//2 6//2 8//2 7//2\n"
                   "usemtl blue\ng side\ns off\nf 1/1 2/2 6/1 5/2\nf -6 -2 -1 -5 # relative\n"
                   "f 1 5 7 3\nf 2 4 8 6\n"),
        8);
}

TEST(obj_numbers_and_digits_are_those_of_the_file)
{
    /* Used backwards; the third vertex is used by none, the last lies on the first. */
    ss_mesh *m = load(write_text("order.obj", "v 0.12345678901234567 0 0\nv 1 0 0\nv 9 9 9\n"
                                              "v 0 1 0\nv 0 0 1\nv 0.12345678901234567 -0 0\n"
                                              "f 5 4 2\nf 4 5 6\nf 1 2 4\nf 5 2 1\n"),
                      1.0);
    assert_int_equal(m->node_count, 4);
    assert_near(m->position[0][0], 0.12345678901234567, 0.0);
    assert_near(m->position[1][0], 1.0, 0.0);
    assert_near(m->position[2][1], 1.0, 0.0);
    assert_near(m->position[3][2], 1.0, 0.0);
    const int32_t expected[4][3] = {{3, 2, 1}, {2, 3, 0}, {0, 1, 2}, {3, 1, 0}};
    assert_memory_equal(m->triangle, expected, sizeof expected);
    ss_mesh_destroy(&m);
}

TEST(concave_polygons_are_cut_within_their_outline)
{
    /* An L of area 3: a fan from its first corner would cover more. */
    ss_mesh *m = load(write_text("ell.obj", "v 1 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\n"
                                            "f 5 6 1 2 3 4\n"),
                      1.0);
    ss_mesh_report r;
    (void)ss_mesh_check(m, &r);
    assert_near(r.area, 3.0, 1e-6);
    assert_int_equal(r.inconsistent_winding.count, 0);
    ss_mesh_destroy(&m);
}

/* The cube's triangles, corners numbered by bits x y z. */
static const int cube_face[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                     {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                     {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

static void expect_cut(const char *name, const void *data, size_t size, const char *says)
{
    ss_mesh *m = NULL;
    softsim_error error = {0};
    assert_int_equal(ss_mesh_load(write_bytes(name, data, size), 1.0, importer, &m, &error),
                     SOFTSIM_ERROR_FORMAT);
    if (error.fault_count != 1 || strstr(error.text, says) == NULL) {
        fail_msg("%s: %s", name, error.text);
    }
}

TEST(ascii_and_binary_stl_join_their_corners)
{
    char text[8192] = "solid facet normal\n"; /* a name may be words of the format */
    char binary[84 + 12 * 50] = "binary";
    const uint32_t count = 12;
    memcpy(binary + 80, &count, sizeof count);
    for (int t = 0; t < 12; ++t) {
        size_t used = strlen(text);
        used +=
            (size_t)snprintf(text + used, sizeof text - used, "facet normal 0 0 0\nouter loop\n");
        for (int k = 0; k < 3; ++k) {
            const int c = cube_face[t][k];
            const float x[3] = {(float)(c & 1), (float)(c >> 1 & 1), (float)(c >> 2)};
            memcpy(binary + 84 + 50 * t + 12 + 12 * k, x, sizeof x);
            used += (size_t)snprintf(text + used, sizeof text - used, "vertex %g %g %g\n",
                                     (double)x[0], (double)x[1], (double)x[2]);
        }
        (void)snprintf(text + used, sizeof text - used, "endloop\nendfacet\n");
    }
    strcat(text, "endsolid facet\n");
    expect_cube(write_text("ascii.stl", text), 8);
    expect_cube(write_bytes("binary.STL", binary, sizeof binary), 8);
    expect_cut("cut.stl", binary, sizeof binary - 60,
               "cut.stl: it is cut off: its header says 12 triangles, and 10 are there: ");
    expect_cut("headless.stl", binary, 84, "says 12 triangles, and 0 are there: ");
    const size_t size = strlen(text), end = strlen("endsolid facet\n");
    expect_cut("endless.stl", text, size - end,
               "endless.stl:86: it is cut off: no endsolid after 12 whole triangles: ");
    expect_cut("word.stl", text, size - end + 5,
               "word.stl:86: it is cut off: no endsolid after 12");
    expect_cut("part.stl", text, size - end - 20,
               "it is cut off: it ends within a triangle after 11 whole triangles: ");
    /* A second body that is cut off before its first triangle. */
    static const char *const second[] = {"solid", "solid b\n", "solid b\nfacet nor"};
    for (int k = 0; k < 3; ++k) {
        (void)snprintf(text + size, sizeof text - size, "%s", second[k]);
        expect_cut("second.stl", text, strlen(text), "no endsolid after 12 whole triangles: ");
    }
}

/* The cube as PLY of a `format`, text or binary. */
static size_t make_ply(const char *format, char *out, size_t room)
{
    const bool is_text = strcmp(format, "ascii") == 0, is_big = strstr(format, "big") != NULL;
    size_t used = (size_t)snprintf(
        out, room,
        "ply\nformat %s 1.0\ncomment a cube\nelement vertex 8\nproperty float x\nproperty float "
        "y\nproperty float z\nelement face 12\nproperty list uchar int "
        "vertex_indices\nend_header\n",
        format);
    for (int c = 0; c < 8; ++c) {
        const float x[3] = {(float)(c & 1), (float)(c >> 1 & 1), (float)(c >> 2)};
        if (is_text) {
            used += (size_t)snprintf(out + used, room - used, "%g %g %g\n", (double)x[0],
                                     (double)x[1], (double)x[2]);
        }
        for (int k = 0; k < 12 && !is_text; ++k) {
            out[used++] = ((const char *)x)[is_big ? k / 4 * 4 + 3 - k % 4 : k];
        }
    }
    for (int t = 0; t < 12; ++t) {
        if (is_text) {
            used += (size_t)snprintf(out + used, room - used, "3 %d %d %d\n", cube_face[t][0],
                                     cube_face[t][1], cube_face[t][2]);
            continue;
        }
        out[used++] = 3;
        for (int k = 0; k < 12; ++k) {
            const int byte = is_big ? 3 - k % 4 : k % 4;
            out[used++] = (char)(byte == 0 ? cube_face[t][k / 4] : 0);
        }
    }
    return used;
}

TEST(ply_is_read_whole_or_told_to_be_cut_off)
{
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    for (int f = 0; f < 3; ++f) {
        char bytes[2048], says[128];
        const size_t size = make_ply(formats[f], bytes, sizeof bytes);
        expect_cube(write_bytes("whole.ply", bytes, size), 8);
        const size_t head = (size_t)(strstr(bytes, "end_header\n") + 11 - bytes);
        for (size_t cut = 2; cut < size - head; cut += 7) {
            expect_cut("cut.ply", bytes, size - cut, "it is cut off: its header says ");
        }
        (void)snprintf(says, sizeof says, "says 12 of element face, and 11 are whole: ");
        expect_cut("last.ply", bytes, size - (f == 0 ? 3 : 1), says);
    }
}

/* The cube with positions and indices in the file `uri`. */
static const char *write_gltf(const char *name, const char *uri)
{
    char text[2048];
    (void)snprintf(text, sizeof text,
                   "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                   "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
                   "{\"POSITION\":0},\"indices\":1}]}],\"buffers\":[{\"uri\":\"%s\","
                   "\"byteLength\":168}],\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,"
                   "\"byteLength\":96},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":72}],"
                   "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":8,"
                   "\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,1]},{\"bufferView\":1,"
                   "\"componentType\":5123,\"count\":36,\"type\":\"SCALAR\"}]}",
                   uri);
    return write_text(name, text);
}

/* Materials are left out however their line is told from others: a pipe in their place would be
 * waited for. */
TEST(materials_of_an_obj_are_not_opened)
{
    /* Space, a continued line, and what assimp takes for the end of one. */
    static const char *const lines[] = {"mtllib %s\n", "mtllib\\\n %s\n", "g a\rmtllib %s\n",
                                        "mtllib\f%s\n", "g a\fmtllib %s\n"};
    char out[256], text[512];
    assert_int_equal(run("mkfifo pipe.mtl", out, sizeof out), 0);
    for (size_t i = 0; i < sizeof lines / sizeof *lines; ++i) {
        const char *tail = strstr(lines[i], "%s");
        const int used = snprintf(text, sizeof text, "%.*s%s%s", (int)(tail - lines[i]), lines[i],
                                  in_folder("pipe.mtl"), tail + 2);
        (void)snprintf(text + used, sizeof text - (size_t)used,
                       "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        ss_mesh *mesh = load(write_text("material.obj", text), 1.0);
        assert_int_equal(mesh->triangle_count, 1);
        ss_mesh_destroy(&mesh);
    }
}

TEST(ascii_ply_and_gltf_are_read)
{
    char text[4096];
    size_t used = (size_t)snprintf(text, sizeof text,
                                   "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\n"
                                   "property float y\nproperty float z\nelement face 12\n"
                                   "property list uchar int vertex_indices\nend_header\n");
    for (int c = 0; c < 8; ++c) {
        used += (size_t)snprintf(text + used, sizeof text - used, "%d %d %d\n", c & 1, c >> 1 & 1,
                                 c >> 2);
    }
    for (int t = 0; t < 12; ++t) {
        used += (size_t)snprintf(text + used, sizeof text - used, "3 %d %d %d\n", cube_face[t][0],
                                 cube_face[t][1], cube_face[t][2]);
    }
    expect_cube(write_text("cube.ply", text), 8);

    /* Positions and indices in a file beside it. */
    char bytes[8 * 12 + 12 * 6];
    for (int c = 0; c < 8; ++c) {
        const float x[3] = {(float)(c & 1), (float)(c >> 1 & 1), (float)(c >> 2)};
        memcpy(bytes + 12 * c, x, sizeof x);
    }
    for (int t = 0; t < 12; ++t) {
        for (int k = 0; k < 3; ++k) {
            const uint16_t index = (uint16_t)cube_face[t][k];
            memcpy(bytes + 96 + 6 * t + 2 * k, &index, sizeof index);
        }
    }
    (void)write_bytes("cube.bin", bytes, sizeof bytes);
    expect_cube(write_gltf("cube.gltf", "cube.bin"), 8);
}

/* A mesh from elsewhere must not read what is not beside it, nor wait for it. */
TEST(gltf_reads_nothing_that_is_not_beside_it)
{
    static const says_row cases[] = {
        {"beside.bin", NULL},
        {"below/cube.bin", NULL},
        {"../cube.bin", "it names"},
        {"below/../../cube.bin", "it names"},
        {"leads-out.bin", "not beside it; put what it needs into its own folder"},
        {"leads-beside.bin", NULL},
        {"pipe.bin", "a pipe, not a file"},
        {"zero.bin", "it names"},
        {"below", "a folder, not a file"},
        {"none.bin", "No such file"},
    };
    char out[256];
    assert_int_equal(run("mkdir -p in/below && cp cube.bin in/beside.bin && "
                         "cp cube.bin in/below/cube.bin && ln -s ../cube.bin in/leads-out.bin && "
                         "ln -s below/cube.bin in/leads-beside.bin && mkfifo in/pipe.bin && "
                         "ln -s /dev/zero in/zero.bin",
                         out, sizeof out),
                     0);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const char *path = write_gltf("in/cube.gltf", cases[i].given);
        softsim_error error = {0};
        ss_mesh *mesh = NULL;
        const softsim_status status = ss_mesh_load(path, 1e-3, importer, &mesh, &error);
        if ((status == SOFTSIM_OK) != (cases[i].says == NULL) ||
            (cases[i].says != NULL && strstr(error.text, cases[i].says) == NULL)) {
            fail_msg("%s: %s", cases[i].given, error.text);
        }
        ss_mesh_destroy(&mesh);
    }
}

/* ---- hostile files ---- */

static const struct {
    const char *name, *text, *says;
    softsim_status status;
} bad_files[] = {
    {"empty.obj", "", "the file is empty", SOFTSIM_ERROR_FORMAT},
    {"text.obj", "hello\n", "no vertices in it", SOFTSIM_ERROR_FORMAT},
    {"points.obj", "v 0 0 0\nv 1 0 0\n", "", SOFTSIM_ERROR_FORMAT},
    {"nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "nan.obj:3: the position",
     SOFTSIM_ERROR_FORMAT},
    {"huge.obj", "v 0 0 0\nv 1 0 0\nv 0 1e999 0\nf 1 2 3\n", "huge.obj:3: the position",
     SOFTSIM_ERROR_FORMAT},
    {"short.obj", "v 0 0 0\nv 1 0\nv 0 0 0\nf 1 2 3\n", "short.obj:2: a vertex has",
     SOFTSIM_ERROR_FORMAT},
    {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "", SOFTSIM_ERROR_FORMAT},
    {"negative.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9\n", "", SOFTSIM_ERROR_FORMAT},
    {"nan.stl",
     "solid s\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 nan 0\n"
     "vertex 0 1 0\nendloop\nendfacet\nendsolid s\n",
     "not finite", SOFTSIM_ERROR_FORMAT},
    {"garbage.stl", "\x01\x02\xff\xfe garbage", "", SOFTSIM_ERROR_FORMAT},
    {"garbage.ply",
     "ply\nformat ascii 1.0\nelement vertex 2000000000\nproperty float x\n"
     "end_header\n1\n",
     "", SOFTSIM_ERROR_FORMAT},
    {"garbage.glb", "glTF\x02", "", SOFTSIM_ERROR_FORMAT},
    {"garbage.gltf", "{\"asset\":", "", SOFTSIM_ERROR_FORMAT},
    {"garbage.msh",
     "\x7f"
     "ELF",
     "not a mesh that is read here", SOFTSIM_ERROR_FORMAT},
    {"noend", "v 0 0 0\n", "not a mesh that is read here", SOFTSIM_ERROR_FORMAT},
    {"wrong.obj", "$MeshFormat\n4.1 1 8\n$EndMeshFormat\n", "Gmsh format 4.1 binary",
     SOFTSIM_ERROR_FORMAT},
};

TEST(each_hostile_file_gives_one_error_that_names_it)
{
    for (int32_t i = 0; i < COUNT(bad_files); ++i) {
        ss_mesh *m = NULL;
        softsim_error error = {0};
        const char *path = write_text(bad_files[i].name, bad_files[i].text);
        const softsim_status status = ss_mesh_load(path, 1.0, importer, &m, &error);
        if (status != bad_files[i].status || m != NULL || error.fault_count != 1 ||
            strstr(error.text, path) != error.text ||
            strstr(error.text, bad_files[i].says) == NULL || strchr(error.text, '\n') != NULL) {
            fail_msg("%s: status %d, %d faults: %s", bad_files[i].name, status, error.fault_count,
                     error.text);
        }
    }
}

TEST(what_is_no_file_is_named_so)
{
    ss_mesh *m = NULL;
    softsim_error error = {0};
    assert_int_equal(ss_mesh_load(in_folder("missing.obj"), 1.0, importer, &m, &error),
                     SOFTSIM_ERROR_FILE);
    assert_int_equal(ss_mesh_load(folder, 1.0, importer, &m, &error), SOFTSIM_ERROR_FILE);
    const char *fifo = in_folder("fifo.obj");
    assert_int_equal(mkfifo(fifo, 0600), 0);
    assert_int_equal(ss_mesh_load(fifo, 1.0, importer, &m, &error), SOFTSIM_ERROR_FILE);
    assert_int_equal(error.fault_count, 3);
    assert_non_null(strstr(error.text, "No such file"));
    assert_non_null(strstr(error.text, "a folder"));
    assert_non_null(strstr(error.text, "not a file"));
    const char *good = write_text("unit.obj", CUBE_V "f 1 2 3\n");
    assert_int_equal(ss_mesh_load(good, 0.0, importer, &m, &error), SOFTSIM_ERROR_ARGUMENT);
    assert_int_equal(ss_mesh_load(good, NAN, importer, &m, &error), SOFTSIM_ERROR_ARGUMENT);
    assert_null(m);
}

TEST(damaged_files_never_bring_the_reader_down)
{
    /* The bundled kidney with bytes changed, as OBJ; seeded. */
    FILE *file = fopen(SOURCE_DIR "/server/scenes/kidney.obj", "rb");
    assert_non_null(file);
    static char text[1 << 18];
    const size_t size = fread(text, 1, sizeof text, file);
    assert_int_equal(fclose(file), 0);
    uint64_t random = 7;
    for (int round = 0; round < 24; ++round) {
        static char damaged[sizeof text];
        memcpy(damaged, text, size);
        for (int k = 0; k < 1 << (round % 8); ++k) {
            damaged[ss_random_next(&random) % size] = (char)ss_random_next(&random);
        }
        ss_mesh *m = NULL;
        softsim_error error = {0};
        const size_t length = round % 3 == 0 ? (random >> 5) % size : size;
        if (ss_mesh_load(write_bytes("damaged.obj", damaged, length), 0.001, importer, &m,
                         &error) == SOFTSIM_OK) {
            ss_mesh_report r;
            (void)ss_mesh_check(m, &r);
            assert_int_equal(r.bad_index.count, 0);
            assert_int_equal(r.non_finite.count, 0);
        } else {
            assert_true(error.fault_count > 0);
        }
        ss_mesh_destroy(&m);
    }
}

#define PLY_HEAD                                                                                   \
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float " \
    "z\n"
#define PLY_FACE  "element face 1\nproperty list uchar int vertex_indices\n"
#define PLY_TEXT  "end_header\n0 0 0\n1 0 0\n0 1 0\n"
#define NO_BODY   "no triangle, so there is no body in it: give a surface"
#define OBJ_THREE "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

/* assimp's later steps crash on such scenes. */
TEST(files_without_a_face_get_words_of_their_own)
{
    const struct {
        const char *name, *text, *says;
    } files[] = {
        {"lines.obj", OBJ_THREE "l 1 2 3\n", "it holds 2 lines and " NO_BODY},
        {"points.obj", OBJ_THREE "p 1 2\n", "it holds 2 points and " NO_BODY},
        {"both.obj", OBJ_THREE "l 1 2\np 3\n", "it holds 1 lines and 1 points and " NO_BODY},
        {"vertices.obj", OBJ_THREE, "it holds 3 points and " NO_BODY},
        {"points.ply", PLY_HEAD PLY_TEXT, "it holds 3 points and " NO_BODY},
        {"line.ply", PLY_HEAD PLY_FACE PLY_TEXT "2 0 1\n", "it holds 1 lines and " NO_BODY},
        {"empty.stl", "solid a\nendsolid a\n", "it holds " NO_BODY}};
    for (int32_t i = 0; i < COUNT(files); ++i) {
        ss_mesh *m = NULL;
        softsim_error error = {0};
        assert_int_equal(
            ss_mesh_load(write_text(files[i].name, files[i].text), 1.0, importer, &m, &error),
            SOFTSIM_ERROR_FORMAT);
        if (error.fault_count != 1 || strstr(error.text, files[i].says) == NULL) {
            fail_msg("%s: %s", files[i].name, error.text);
        }
        assert_null(m);
    }
}

/* ---- the helper's faults ---- */

static const char *write_helper(const char *name, const char *script)
{
    const char *path = write_text(name, script);
    assert_int_equal(chmod(path, 0700), 0);
    return path;
}

TEST(a_helper_that_fails_in_any_way_is_one_error)
{
    const struct {
        const char *script, *says;
    } helpers[] = {
        {"#!/bin/sh\nkill -SEGV $$\n",
         "the importer itself ended by signal 11 (Segmentation fault)"},
        {"#!/bin/sh\nkill -ABRT $$\n", "the importer itself ended by signal 6 (Aborted)"},
        {"#!/bin/sh\necho \"terminate called after throwing an instance of 'std::bad_alloc'\" >&2\n"
         "kill -ABRT $$\n",
         "too large for the importer's memory"},
        {"#!/bin/sh\nkill -XCPU $$\n", "the importer used up its 5 s of CPU time"},
        {"#!/bin/sh\necho \"bad\033[31m thing\" >&2; echo more >&2; exit 2\n", "bad?[31m thing"},
        {"#!/bin/sh\nexit 3\n", "gave no reason"},
        {"#!/bin/sh\nexit 0\n", "cut off"},
        {"#!/bin/sh\nhead -c 4000 /dev/zero\n", "makes no sense"},
        {"#!/bin/sh\nprintf 'softsim3\\377\\377\\377\\377\\377\\377\\377\\177'\n"
         "printf '\\377\\377\\377\\377\\377\\377\\377\\177'; head -c 44 /dev/zero\n",
         "makes no sense"},
        {"#!/bin/sh\nprintf 'softsim3\\3\\0\\0\\0\\0\\0\\0\\0'; head -c 8 /dev/zero\n"
         "printf '\\377\\377\\377\\377\\377\\377\\377\\177'; head -c 112 /dev/zero\n",
         "makes no sense"},
        {"not a program", "cannot start"},
    };
    (void)write_text("helped.obj", CUBE_V "f 1 2 3\n");
    for (int32_t i = 0; i < COUNT(helpers); ++i) {
        ss_mesh *m = NULL;
        softsim_error error = {0};
        const char *helper = write_helper("helper", helpers[i].script);
        assert_int_not_equal(ss_mesh_load(in_folder("helped.obj"), 1.0, helper, &m, &error),
                             SOFTSIM_OK);
        if (error.fault_count != 1 || strstr(error.text, helpers[i].says) == NULL) {
            fail_msg("helper %d: %s", i, error.text);
        }
        assert_null(m);
    }
    ss_mesh *m = NULL;
    softsim_error error = {0};
    assert_int_equal(ss_mesh_load(in_folder("helped.obj"), 1.0, in_folder("nowhere"), &m, &error),
                     SOFTSIM_ERROR_SYSTEM);
    assert_non_null(strstr(error.text, "softsim-import is not there"));
}

/* Holes of a gigabyte, of which reading touches nothing: the first allocation fails. The mesh is
 * not wrong, and writing it again would not help. */
TEST(memory_that_runs_out_is_called_so)
{
    unsigned char stl[84] = {0};
    const uint32_t facets = 21470000; /* just below a GiB */
    memcpy(stl + 80, &facets, sizeof facets);
    const struct {
        const char *name;
        const void *head;
        size_t head_size;
        int64_t size;
    } large[] = {{"large.stl", stl, sizeof stl, 84 + 50 * (int64_t)facets},
                 {"large.obj", "v 0 0 0\n", 8, 1050000000}};
    if (IS_REPEATED) {
        skip(); /* a sanitizer's address space has no limit */
    }
    /* Of an OBJ each byte is looked at before. */
    for (size_t i = 0; i < FULL_IN_LONG_RUN(sizeof large / sizeof *large, 1); ++i) {
        FILE *file = fopen(in_folder(large[i].name), "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(large[i].head, large[i].head_size, 1, file), 1);
        assert_int_equal(fflush(file), 0);
        assert_int_equal(ftruncate(fileno(file), large[i].size), 0);
        fclose(file);
        ss_mesh *mesh = NULL;
        softsim_error error = {0};
        assert_int_not_equal(ss_mesh_load(in_folder(large[i].name), 1.0, importer, &mesh, &error),
                             SOFTSIM_OK);
        if (strstr(error.text, "too large for 1 GiB of memory") == NULL || error.fault_count != 1) {
            fail_msg("%s", error.text);
        }
        assert_int_equal(unlink(in_folder(large[i].name)), 0);
    }
}

/* Of who started it: that limit stays, and is the one that is named. */
TEST(a_lower_limit_of_memory_is_called_so)
{
    char script[4096];
    (void)snprintf(script, sizeof script, "#!/bin/sh\nulimit -v 65536\nexec '%s' \"$@\"\n",
                   importer);
    if (IS_REPEATED) {
        skip();
    }
    const char *helper = write_helper("limited", script);
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    assert_int_not_equal(
        ss_mesh_load(write_text("small.obj", CUBE_V "f 1 2 3\n"), 1.0, helper, &mesh, &error),
        SOFTSIM_OK);
    if (strstr(error.text, "the 64 MiB of memory that are allowed here (ulimit -v)") == NULL) {
        fail_msg("%s", error.text);
    }
}

TEST(an_answer_with_bad_contents_is_refused)
{
    const double positions[2][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                                       {{0, 0, 0}, {1, 0, 0}, {0, INFINITY, 0}}};
    const int32_t triangles[2][1][3] = {{{0, 1, 3}}, {{0, 1, 2}}};
    const char *says[] = {"does not exist", "not finite"};
    for (int i = 0; i < 2; ++i) {
        char answer[sizeof(ss_import_header) + 72 + 12];
        const ss_import_header header = {
            .magic = SS_IMPORT_MAGIC, .node_count = 3, .triangle_count = 1};
        memcpy(answer, &header, sizeof header);
        memcpy(answer + sizeof header, positions[i], 72);
        memcpy(answer + sizeof header + 72, triangles[i], 12);
        (void)write_bytes("answer", answer, sizeof answer);
        char script[512];
        (void)snprintf(script, sizeof script, "#!/bin/sh\ncat %s\n", in_folder("answer"));
        const char *path = write_text("helped.obj", "x");
        ss_mesh *m = NULL;
        softsim_error error = {0};
        assert_int_equal(ss_mesh_load(path, 1.0, write_helper("helper", script), &m, &error),
                         SOFTSIM_ERROR_FORMAT);
        assert_non_null(strstr(error.text, says[i]));
    }
}

/* ---- writing ---- */

TEST(meshes_come_back_from_disk_as_they_were)
{
    ss_mesh *kidney = load(SOURCE_DIR "/server/scenes/kidney.obj", 0.001);
    ss_mesh_transform(kidney, 1.0 / 3.0, (double[3]){10, 20, 30}, (double[3]){0.1, 0.2, 0.3});
    const char *paths[] = {in_folder("back.msh"), in_folder("back.obj")};
    assert_int_equal(ss_mesh_write_msh(kidney, paths[0], NULL), SOFTSIM_OK);
    assert_int_equal(ss_mesh_write_obj(kidney, paths[1], NULL), SOFTSIM_OK);
    for (int i = 0; i < 2; ++i) {
        ss_mesh *back = load(paths[i], 1.0);
        assert_int_equal(back->node_count, kidney->node_count);
        assert_int_equal(back->triangle_count, kidney->triangle_count);
        assert_memory_equal(back->triangle, kidney->triangle,
                            (size_t)kidney->triangle_count * sizeof *kidney->triangle);
        for (int32_t n = 0; n < kidney->node_count; ++n) {
            for (int k = 0; k < 3; ++k) {
                assert_near(back->position[n][k], kidney->position[n][k], i == 0 ? 0.0 : 1e-9);
            }
        }
        ss_mesh_destroy(&back);
    }
    ss_mesh_destroy(&kidney);

    softsim_error error = {0};
    ss_mesh *cube = load(write_text("cube2.obj", CUBE_V "f 1 2 3\n"), 1.0);
    assert_int_equal(ss_mesh_write_obj(cube, in_folder("no/such/folder.obj"), &error),
                     SOFTSIM_ERROR_FILE);
    assert_int_equal(error.fault_count, 1);
    char listing[4096];
    assert_int_equal(run("ls", listing, sizeof listing), 0);
    assert_null(strstr(listing, ".tmp"));
    ss_mesh_destroy(&cube);
}

TEST(groups_and_tetrahedra_survive_msh)
{
    const char *text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"a b\"\n"
                       "3 2 \"all\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
                       "4 0 0 1\n$EndNodes\n$Elements\n2\n1 2 2 1 1 1 3 2\n2 4 2 2 1 1 2 3 4\n"
                       "$EndElements\n";
    ss_mesh *first = load(write_text("groups.msh", text), 1.0);
    const char *path = in_folder("groups2.msh");
    assert_int_equal(ss_mesh_write_msh(first, path, NULL), SOFTSIM_OK);
    ss_mesh *second = load(path, 1.0);
    assert_int_equal(second->tetrahedron_count, 1);
    assert_int_equal(second->triangle_count, 4);
    assert_int_equal(second->group_count, 2);
    for (int g = 0; g < 2; ++g) {
        assert_string_equal(second->group[g].name, first->group[g].name);
        assert_int_equal(second->group[g].node_count, first->group[g].node_count);
    }
    ss_mesh_destroy(&first);
    ss_mesh_destroy(&second);
}

/* ---- softsim-mesh ---- */

TEST(generated_organs_are_closed_even_and_of_the_points_asked_for)
{
    SKIP_WHERE_REPEATED();
    const struct {
        const char *arguments;
        int32_t points;
        double size_mm[3];
    } organs[] = {{"kidney", 1200, {110, 60, 45}},
                  {"kidney --points 401", 401, {110, 60, 45}},
                  {"kidney --points 2500", 2500, {110, 60, 45}},
                  {"liver --points 1500", 1500, {200, 124, 84}},
                  {"ellipsoid --points 642 --size-mm 120,60,80", 642, {120, 60, 80}}};
    for (int32_t i = 0; i < COUNT(organs); ++i) {
        run_tool("generate %s --out organ.obj", organs[i].arguments);
        ss_mesh *m = load(in_folder("organ.obj"), 0.001);
        ss_mesh_report r;
        (void)ss_mesh_check(m, &r);
        assert_int_equal(m->node_count, organs[i].points);
        assert_int_equal(m->triangle_count, 2 * organs[i].points - 4);
        assert_int_equal(r.component_count, 1);
        assert_true(m->is_closed);
        assert_true(r.angle_min > 25.0);
        assert_true(r.edge_max < 2.8 * r.edge_min);
        for (int k = 0; k < 3; ++k) {
            assert_near(1e3 * (r.box_max[k] - r.box_min[k]), organs[i].size_mm[k],
                        0.04 * organs[i].size_mm[k]);
        }
        assert_int_equal(ss_mesh_accept(m, "organ.obj", NULL), SOFTSIM_OK);
        ss_mesh_destroy(&m);
    }
}

TEST(bundled_meshes_are_what_the_generator_makes)
{
    SKIP_WHERE_REPEATED();
    const struct {
        const char *arguments, *name;
        double unit;
    } bundles[] = {{"kidney", "kidney.obj", 0.001},
                   {"liver --points 1500", "liver.obj", 0.001},
                   {"cylinder", "cylinder.obj", 1.0},
                   {"kidney --points 300", "../../tests/common/kidney-300.obj", 0.001}};
    for (int32_t i = 0; i < COUNT(bundles); ++i) {
        char text[512];
        run_tool("generate %s --out again.obj", bundles[i].arguments);
        (void)snprintf(text, sizeof text, SOURCE_DIR "/server/scenes/%s", bundles[i].name);
        ss_mesh *bundled = load(text, bundles[i].unit);
        ss_mesh *again = load(in_folder("again.obj"), bundles[i].unit);
        assert_int_equal(bundled->node_count, again->node_count);
        assert_memory_equal(bundled->triangle, again->triangle,
                            (size_t)again->triangle_count * sizeof *again->triangle);
        assert_nodes_near(again, bundled, 2e-7);
        ss_mesh_destroy(&bundled);
        ss_mesh_destroy(&again);
    }
}

TEST(kidney_has_a_hollow_and_neighbours_near_in_memory)
{
    ss_mesh *m = load(SOURCE_DIR "/server/scenes/kidney.obj", 0.001);
    /* At the hilum the surface lies deeper than at both ends of it. */
    double hilum = 0.0;
    double lip[2] = {0.0, 0.0};
    int32_t in_box = 0;
    for (int32_t i = 0; i < m->node_count; ++i) {
        const double *x = m->position[i];
        hilum = fabs(x[0]) < 5e-3 ? fmin(hilum, x[1]) : hilum;
        lip[0] = x[0] < -25e-3 && x[0] > -40e-3 ? fmin(lip[0], x[1]) : lip[0];
        lip[1] = x[0] > 25e-3 && x[0] < 40e-3 ? fmin(lip[1], x[1]) : lip[1];
        in_box += fabs(x[0]) < 15e-3 && x[1] < -10e-3 && fabs(x[2]) < 12e-3;
    }
    assert_true(hilum - fmax(lip[0], lip[1]) > 5e-3);
    assert_true(in_box > 20 && in_box < 120);

    double sum = 0.0;
    for (int32_t t = 0; t < m->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            sum += abs(m->triangle[t][k] - m->triangle[t][(k + 1) % 3]);
        }
    }
    /* In random order it would be a third of the number of nodes. */
    assert_true(sum / (3.0 * m->triangle_count) < 0.05 * m->node_count);
    ss_mesh_destroy(&m);
}

TEST(grids_have_rows_columns_and_alternating_diagonals)
{
    char out[1024];
    static const char cylinder[] =
        TOOL "generate cylinder --rows 15 --columns 24 --radius-m 1 --length-m 4 --out c.obj";
    assert_int_equal(run(cylinder, out, sizeof out), 0);
    ss_mesh *m = load(in_folder("c.obj"), 1.0);
    ss_mesh_report r;
    (void)ss_mesh_check(m, &r);
    assert_int_equal(m->node_count, 360);
    assert_int_equal(m->triangle_count, 2 * 14 * 24);
    assert_int_equal(r.open_edge.count, 48);
    assert_near(m->position[7 * 24 + 6][1], 1.0, 1e-8); /* the top, in the middle */
    assert_near(m->position[7 * 24 + 6][2], 0.0, 1e-8);
    double outward = 0.0;
    int32_t valence[360] = {0};
    double vector[360][3];
    ss_mesh_node_area_vectors(m, vector);
    for (int i = 0; i < 360; ++i) {
        outward = vector[i][0] * m->position[i][0] + vector[i][1] * m->position[i][1];
        assert_true(outward > 0.0);
    }
    for (int32_t t = 0; t < m->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            ++valence[m->triangle[t][k]];
        }
    }
    for (int i = 24; i < 336; ++i) {
        assert_int_equal(valence[i], (i / 24 + i % 24) % 2 == 0 ? 8 : 4);
    }
    ss_mesh_destroy(&m);

    static const char plane[] =
        TOOL "generate plane --rows 5 --columns 9 --width-m 0.2 --units mm --out p.msh";
    assert_int_equal(run(plane, out, sizeof out), 0);
    m = load(in_folder("p.msh"), 0.001);
    (void)ss_mesh_check(m, &r);
    assert_int_equal(m->node_count, 45);
    assert_near(r.area, 0.02, 1e-12);
    ss_mesh_destroy(&m);
}

TEST(check_and_info_exit_as_promised)
{
    (void)write_text("good.obj", CUBE_V "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\n"
                                        "f 2 4 8 6\n");
    (void)write_text("open.obj", CUBE_V "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\n");
    (void)write_text("mixed.obj", CUBE_V "f 1 3 4 2\nf 5 6 8\nf 5 8 7\n");
    (void)write_text("twice.obj", CUBE_V "f 1 3 4\nf 1 3 4\nf 3 1 2\n");
    static const tool_row rows[] = {
        {"check good.obj", 0, "good.obj: good"},
        {"check open.obj", 1, "open.obj: open edges: 4"},
        {"check twice.obj", 2, "twice.obj: duplicate triangles: 1"},
        {"check missing.obj", 2, "softsim-mesh: missing.obj: cannot read it"},
        {"check good.obj --units m", 0, "good"},
        {"check good.obj --units miles", 2, "not one of mm|cm|dm|m"},
        {"check", 2, "usage: softsim-mesh check FILE"},
        {"info good.obj", 0, "volume      1\n"},
        {"info good.obj --nodes --units m", 0, "\n7,1,1,1\n"},
        {"info good.obj extra", 2, "too many"},
        {"generate", 2, "missing"},
        {"generate spleen", 2, "'spleen' is not one of kidney|liver"},
        {"generate kidney --points 3", 2, "--points: 3 is out of range"},
        {"generate kidney --rows 9", 2, "--rows means nothing for a kidney"},
        {"generate plane --points 99 --radius-m 2", 2, "--radius-m means nothing for a plane"},
        {"generate ellipsoid --size-mm 1,2", 2, "--size-mm: '1,2'"},
        {"generate ellipsoid --size-mm 100,2,2", 2, "10 times another"},
        {"generate cylinder --columns 2", 2, "at least 3"},
        {"generate cylinder --grid --out grid.obj", 0, "grid.obj: 360 nodes, 336 quads, in m"},
        {"info grid.obj --units m", 0, "\nquads       336 "},
        {"info grid.obj --units m", 0, "\ndirections  0 edges"},
        {"generate plane --grid --out grid.msh", 0, "grid.msh: 441 nodes, 400 quads, in m"},
        {"info grid.msh --units m", 0, "\nquads       400 "},
        {"info mixed.obj", 0, "\ncut_faces   1 of more than three corners"},
        {"generate liver --grid", 2, "--grid means nothing for a liver"},
        {"generate cylinder --rows 1000 --columns 1000000", 2, "--columns"},
        {"generate plane --out plane.gltf", 2, "ends in none of .obj, .msh, .vtk, .stl"},
        {"generate plane --out no/such/plane.obj", 1, "cannot write it"},
        {"generate --help", 0, "--size-mm X,Y,Z"},
        {"melt", 2, "'melt' is not one of"},
        {"", 2, "not one of info, check, convert, remesh, tetrahedralize, scene, generate;"},
        {"--help", 0, "usage: softsim-mesh"},
        {"--version", 0, "softsim-mesh " SOFTSIM_VERSION},
    };
    expect_answers(rows, COUNT(rows));
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
