/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Triangles of the Object File Format (Geomview), ASCII without comments:
 *
 *   OFF  points faces edges / x y z ... / 3 node node node ...
 *
 * How a reader of meshes is added: server/mesh/README.md.
 */
#include <string.h>

#include "mesh/readers.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { MIN_POINT = 6, MIN_FACE = 8, MAX_COUNT = 1 << 24 }; /* bytes of the shortest, "0 0 0\n" */

static bool next_integer(ss_text *text, int64_t least, int64_t most, int32_t *out)
{
    ss_text_span word;
    int64_t value = 0;
    const bool is_good = ss_text_next_word(text, &word) && ss_span_integer(word, &value) &&
                         value >= least && value <= most;
    *out = (int32_t)value;
    if (!is_good) {
        ss_text_fault(text, "a whole number of %lld to %lld expected here", (long long)least,
                      (long long)most);
    }
    return is_good;
}

static bool read_arrays(ss_text *text, double metres_per_unit, int32_t nodes, double (*x)[3],
                        int32_t faces, int32_t (*face)[3])
{
    ss_text_span word;
    for (int32_t i = 0; i < 3 * nodes; ++i) {
        double *value = &x[i / 3][i % 3];
        if (!ss_text_next_word(text, &word) || !ss_span_number(word, value)) {
            ss_text_fault(text, "a coordinate of point %d expected here", i / 3);
            return false;
        }
        *value *= metres_per_unit;
    }
    int32_t corners = 0;
    for (int32_t f = 0; f < faces; ++f) {
        if (!next_integer(text, 3, 3, &corners) || !next_integer(text, 0, nodes - 1, &face[f][0]) ||
            !next_integer(text, 0, nodes - 1, &face[f][1]) ||
            !next_integer(text, 0, nodes - 1, &face[f][2])) {
            return false;
        }
    }
    return true;
}

static softsim_status parse(ss_text *text, double metres_per_unit, ss_mesh **out_mesh)
{
    ss_text_span word;
    int32_t nodes = 0, faces = 0, edges = 0;
    (void)ss_text_next_word(text, &word); /* OFF */
    if (!next_integer(text, 1, MAX_COUNT, &nodes) || !next_integer(text, 1, MAX_COUNT, &faces) ||
        !next_integer(text, 0, MAX_COUNT, &edges)) {
        return text->status;
    }
    if ((int64_t)nodes * MIN_POINT + (int64_t)faces * MIN_FACE > ss_text_left(text) + 2) {
        ss_text_fault(text,
                      "%d points and %d faces announced, more than the file has: it is cut "
                      "off",
                      nodes, faces);
        return text->status;
    }
    double(*x)[3] = ss_memory_get((size_t)nodes, sizeof *x);
    int32_t(*face)[3] = ss_memory_get((size_t)faces, sizeof *face);
    if (x == NULL || face == NULL) {
        (void)ss_text_out_of_memory(text);
    } else if (read_arrays(text, metres_per_unit, nodes, x, faces, face)) {
        text->status = ss_mesh_create(nodes, (const double(*)[3])x, faces,
                                      (const int32_t(*)[3])face, 0, NULL, out_mesh, text->error);
    }
    ss_memory_free(x);
    ss_memory_free(face);
    return text->status;
}

static bool sniff(const char *start)
{
    return strncmp(start, "OFF", 3) == 0;
}

static softsim_status read_mesh(const ss_mesh_file *file, ss_mesh **out_mesh)
{
    return ss_mesh_read_text(file, parse, out_mesh);
}

extern const ss_mesh_reader ss_mesh_reader_off;
const ss_mesh_reader ss_mesh_reader_off = {.name = "OFF", .sniff = sniff, .read = read_mesh};
