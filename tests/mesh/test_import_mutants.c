/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Damaged surface files through softsim-import, which ends, gives up or runs out of its limits
 * without harm to the program that asked: each load gives a sound mesh or says why not.
 * test_import_mutants [COUNT] makes COUNT damaged files in all, 40 without.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "common/effort.h"
#include "common/folder_fixture.h"
#include "mesh/mesh.h"
#include "rt/memory.h"
#include "rt/random.h"

enum { MAX_SIZE = 1 << 16, FORMATS = 5 };
static int wanted;

typedef struct seed {
    const char *name;
    size_t size;
    unsigned char data[MAX_SIZE];
} seed;
static seed seeds[FORMATS];

static const double corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
static const int face[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};

/* ---- sound files ---- */

static void __attribute__((format(printf, 2, 3))) put(seed *s, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    s->size += (size_t)vsnprintf((char *)s->data + s->size, MAX_SIZE - s->size, format, arguments);
    va_end(arguments);
}

static void put_bytes(seed *s, const void *data, size_t size)
{
    memcpy(s->data + s->size, data, size);
    s->size += size;
}

static void put_float(seed *s, double value)
{
    const float f = (float)value;
    put_bytes(s, &f, sizeof f);
}

static void put_u32(seed *s, uint32_t value)
{
    put_bytes(s, &value, sizeof value);
}

static void make_obj(seed *s)
{
    s->name = "seed.obj";
    for (int i = 0; i < 8; ++i) {
        put(s, "v %g %g %g\n", corner[i][0], corner[i][1], corner[i][2]);
    }
    for (int t = 0; t < 12; ++t) {
        put(s, "f %d %d %d\n", face[t][0] + 1, face[t][1] + 1, face[t][2] + 1);
    }
}

static void make_text_stl(seed *s)
{
    s->name = "text.stl";
    put(s, "solid cube\n");
    for (int t = 0; t < 12; ++t) {
        put(s, "facet normal 0 0 0\nouter loop\n");
        for (int k = 0; k < 3; ++k) {
            const double *x = corner[face[t][k]];
            put(s, "vertex %g %g %g\n", x[0], x[1], x[2]);
        }
        put(s, "endloop\nendfacet\n");
    }
    put(s, "endsolid cube\n");
}

static void make_binary_stl(seed *s)
{
    static const char head[80] = "cube", none[2] = {0};
    s->name = "binary.stl";
    put_bytes(s, head, sizeof head);
    put_u32(s, 12);
    for (int t = 0; t < 12; ++t) {
        for (int k = 0; k < 3; ++k) {
            put_float(s, 0.0);
        }
        for (int k = 0; k < 9; ++k) {
            put_float(s, corner[face[t][k / 3]][k % 3]);
        }
        put_bytes(s, none, sizeof none);
    }
}

static void make_ply(seed *s)
{
    s->name = "seed.ply";
    put(s, "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
           "property float z\nelement face 12\nproperty list uchar int vertex_indices\n"
           "end_header\n");
    for (int i = 0; i < 8; ++i) {
        put(s, "%g %g %g\n", corner[i][0], corner[i][1], corner[i][2]);
    }
    for (int t = 0; t < 12; ++t) {
        put(s, "3 %d %d %d\n", face[t][0], face[t][1], face[t][2]);
    }
}

static void make_glb(seed *s)
{
    static const char json[] =
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
        "\"indices\":1}]}],\"buffers\":[{\"byteLength\":240}],\"bufferViews\":[{\"buffer\":0,"
        "\"byteOffset\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":144}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[1,1,1]},{\"bufferView\":1,\"componentType\":5125,\"count\":36,"
        "\"type\":\"SCALAR\"}]}";
    const size_t length = (sizeof json - 1 + 3) / 4 * 4;
    s->name = "seed.glb";
    put_bytes(s, "glTF", 4);
    put_u32(s, 2);
    put_u32(s, (uint32_t)(12 + 8 + length + 8 + 240));
    put_u32(s, (uint32_t)length);
    put_bytes(s, "JSON", 4);
    put(s, "%-*s", (int)length, json);
    put_u32(s, 240);
    put_bytes(s, "BIN\0", 4);
    for (int i = 0; i < 24; ++i) {
        put_float(s, corner[i / 3][i % 3]);
    }
    for (int i = 0; i < 36; ++i) {
        put_u32(s, (uint32_t)face[i / 3][i % 3]);
    }
}

/* ---- damage ---- */

static uint64_t state = 1;

static size_t draw(size_t below)
{
    return (size_t)(ss_random_next(&state) % below);
}

static size_t damage(const seed *s, unsigned char *out)
{
    static const char *const word[] = {"nan", "-1",    "99999999999", "1e999",
                                       "0",   "f 1 2", "\n",          "/"};
    size_t size = s->size;
    memcpy(out, s->data, size);
    for (size_t count = 1 + draw(6); count > 0; --count) {
        const size_t at = draw(size);
        switch (draw(6)) {
        case 0:
            out[at] ^= (unsigned char)(1u << draw(8));
            break;
        case 1:
            out[at] = (unsigned char)draw(256);
            break;
        case 2: /* cut */
            size = draw(4) == 0 ? at + 1 : size;
            break;
        case 3: { /* a piece again */
            const size_t piece = draw(64), from = draw(size);
            const size_t length = from + piece < size && at + piece < size ? piece : 0;
            memmove(out + at, out + from, length);
            break;
        }
        case 4: { /* a number that nobody expects */
            const uint32_t value = draw(2) == 0 ? 0xffffffffu : 0x7fffffffu;
            memcpy(out + at, &value, at + 4 <= size ? 4 : 0);
            break;
        }
        default: {
            const char *w = word[draw(sizeof word / sizeof *word)];
            memcpy(out + at, w, at + strlen(w) <= size ? strlen(w) : 0);
            break;
        }
        }
    }
    return size;
}

static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Loads it: true for a mesh, which is then sound. */
static bool load(const char *path)
{
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    const softsim_status status = ss_mesh_load(path, 1.0, BIN_DIR "/softsim-import", &mesh, &error);
    assert_true((status == SOFTSIM_OK) == (mesh != NULL));
    assert_true((status == SOFTSIM_OK) == (error.text[0] == '\0'));
    for (int32_t i = 0; mesh && i < 3 * mesh->node_count; ++i) {
        assert_true(isfinite(mesh->position[i / 3][i % 3]));
    }
    for (int32_t i = 0; mesh && i < 3 * mesh->triangle_count; ++i) {
        const int32_t node = mesh->triangle[i / 3][i % 3];
        assert_true(node >= 0 && node < mesh->node_count);
    }
    ss_mesh_destroy(&mesh);
    assert_int_equal(ss_memory_in_use(), 0);
    return status == SOFTSIM_OK;
}

static void damaged_files_harm_nobody(void **unused)
{
    (void)unused;
    static unsigned char data[MAX_SIZE];
    double longest = 0.0;
    for (int f = 0; f < FORMATS; ++f) {
        const seed *s = &seeds[f];
        const char *path = write_bytes(s->name, s->data, s->size);
        assert_true(load(path));
        int good = 0;
        for (int k = 0; k < wanted / FORMATS; ++k) {
            write_bytes(s->name, data, damage(s, data));
            const double begun = now_s();
            good += load(path);
            longest = fmax(longest, now_s() - begun);
        }
        print_message("%-10s %d damaged files: %d still meshes, %d refused\n", s->name,
                      wanted / FORMATS, good, wanted / FORMATS - good);
        assert_int_equal(remove(path), 0);
    }
    print_message("the longest took %.2f s\n", longest);
    assert_int_equal(rmdir(folder), 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(damaged_files_harm_nobody)};
    wanted = argc > 1 ? atoi(argv[1]) : FULL_IN_LONG_RUN(40, FULL_IN_RELEASE(20, 10));
    make_obj(&seeds[0]);
    make_text_stl(&seeds[1]);
    make_binary_stl(&seeds[2]);
    make_ply(&seeds[3]);
    make_glb(&seeds[4]);
    return cmocka_run_group_tests(tests, make_folder, NULL);
}
