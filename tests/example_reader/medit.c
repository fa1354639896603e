/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Triangles of Medit's .mesh (INRIA, technical report 253), ASCII without comments, its sections in
 * this order and no other:
 *
 *   MeshVersionFormatted 1 Dimension 3
 *   Vertices n / x y z reference ...
 *   Triangles n / vertex vertex vertex reference ...      vertices numbered from 1
 *   End
 *
 * How a reader of meshes is added: server/mesh/README.md.
 */
#include <string.h>

#include "mesh/readers.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { MIN_LINE = 8, MAX_COUNT = 1 << 24 }; /* bytes of the shortest line, "0 0 0 0\n" */

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

static bool next_keyword(ss_text *text, const char *keyword)
{
    ss_text_span word;
    const bool is_good = ss_text_next_word(text, &word) && ss_span_is(word, keyword);
    if (!is_good) {
        ss_text_fault(text, "the word %s expected here", keyword);
    }
    return is_good;
}

/* The head of a section, and room for it. */
static bool begin_section(ss_text *text, const char *keyword, int32_t *out_count)
{
    if (!next_keyword(text, keyword) || !next_integer(text, 1, MAX_COUNT, out_count)) {
        return false;
    }
    if (*out_count > ss_text_left(text) / MIN_LINE) {
        return ss_text_fault_short(text, *out_count, "", keyword);
    }
    return true;
}

static bool read_vertices(ss_text *text, double metres_per_unit, int32_t count, double (*x)[3])
{
    ss_text_span word;
    int32_t reference;
    for (int32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (!ss_text_next_word(text, &word) || !ss_span_number(word, &x[i][k])) {
                ss_text_fault(text, "a coordinate of vertex %d expected here", i + 1);
                return false;
            }
        }
        ss_scale3(x[i], x[i], metres_per_unit);
        if (!next_integer(text, INT32_MIN, INT32_MAX, &reference)) {
            return false;
        }
    }
    return true;
}

static bool read_triangles(ss_text *text, int32_t nodes, int32_t count, int32_t (*face)[3])
{
    int32_t reference;
    for (int32_t f = 0; f < count; ++f) {
        for (int k = 0; k < 3; ++k) {
            if (!next_integer(text, 1, nodes, &face[f][k])) {
                return false;
            }
            --face[f][k];
        }
        if (!next_integer(text, INT32_MIN, INT32_MAX, &reference)) {
            return false;
        }
    }
    return next_keyword(text, "End");
}

static softsim_status parse(ss_text *text, double metres_per_unit, ss_mesh **out_mesh)
{
    int32_t nodes = 0, faces = 0, version = 0, dimension = 0;
    double(*x)[3] = NULL;
    int32_t(*face)[3] = NULL;
    if (next_keyword(text, "MeshVersionFormatted") && next_integer(text, 1, 4, &version) &&
        next_keyword(text, "Dimension") && next_integer(text, 3, 3, &dimension) &&
        begin_section(text, "Vertices", &nodes)) {
        x = ss_memory_get((size_t)nodes, sizeof *x);
    }
    if (x != NULL && read_vertices(text, metres_per_unit, nodes, x) &&
        begin_section(text, "Triangles", &faces)) {
        face = ss_memory_get((size_t)faces, sizeof *face);
    }
    if (face != NULL && read_triangles(text, nodes, faces, face)) {
        text->status = ss_mesh_create(nodes, (const double(*)[3])x, faces,
                                      (const int32_t(*)[3])face, 0, NULL, out_mesh, text->error);
    } else if (text->fault_count == 0) {
        (void)ss_text_out_of_memory(text);
    }
    ss_memory_free(x);
    ss_memory_free(face);
    return text->status;
}

static bool sniff(const char *start)
{
    return strncmp(start, "MeshVersionFormatted", 20) == 0;
}

static softsim_status read_mesh(const ss_mesh_file *file, ss_mesh **out_mesh)
{
    return ss_mesh_read_text(file, parse, out_mesh);
}

extern const ss_mesh_reader ss_mesh_reader_medit;
const ss_mesh_reader ss_mesh_reader_medit = {
    .name = "Medit's .mesh", .sniff = sniff, .read = read_mesh};
