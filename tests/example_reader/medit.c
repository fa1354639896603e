/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Triangles of Medit's .mesh (INRIA, technical report 253), ASCII without comments, in this order:
 * MeshVersionFormatted 1 Dimension 3 Vertices n / x y z reference ... Triangles n / vertex vertex
 * vertex reference ..., vertices numbered from 1. How a reader is added: server/mesh/README.md.
 */
#include <math.h>
#include <string.h>

#include "mesh/readers.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { MIN_LINE = 8 }; /* bytes of the shortest line, "0 0 0 0\n" */

/* A keyword and the whole number behind it. */
static bool next_field(ss_text *text, const char *keyword, int64_t least, int64_t most,
                       int32_t *out)
{
    ss_text_span word;
    int64_t value = 0;
    const bool is_good = ss_text_next_word(text, &word) && ss_span_is(word, keyword) &&
                         ss_text_next_word(text, &word) && ss_span_integer(word, &value) &&
                         value >= least && value <= most;
    *out = (int32_t)value;
    if (!is_good) {
        ss_text_fault(text, "%s and a whole number of %lld to %lld expected here", keyword,
                      (long long)least, (long long)most);
    }
    return is_good;
}

/* Three numbers and a reference, which is passed over. */
static bool next_row(ss_text *text, double out[3])
{
    double number[4];
    for (int k = 0; k < 4; ++k) {
        ss_text_span word;
        if (!ss_text_next_word(text, &word) || !ss_span_number(word, &number[k])) {
            ss_text_fault(text, "three numbers and a reference expected here");
            return false;
        }
    }
    ss_copy3(out, number);
    return true;
}

static bool read_triangles(ss_text *text, int32_t nodes, int32_t count, int32_t (*face)[3])
{
    for (int32_t f = 0; f < count; ++f) {
        double number[3];
        if (!next_row(text, number)) {
            return false;
        }
        for (int k = 0; k < 3; ++k) {
            if (!(number[k] >= 1.0 && number[k] <= nodes && number[k] == floor(number[k]))) {
                ss_text_fault(text, "vertices are numbered from 1 to %d", nodes);
                return false;
            }
            face[f][k] = (int32_t)number[k] - 1;
        }
    }
    return true;
}

static softsim_status parse(ss_text *text, double metres_per_unit, ss_mesh **out_mesh)
{
    int32_t nodes = 0, faces = 0, version = 0, dimension = 0;
    double(*x)[3] = NULL;
    int32_t(*face)[3] = NULL;
    if (next_field(text, "MeshVersionFormatted", 1, 4, &version) &&
        next_field(text, "Dimension", 3, 3, &dimension) &&
        next_field(text, "Vertices", 1, ss_text_left(text) / MIN_LINE, &nodes)) {
        x = ss_memory_get((size_t)nodes, sizeof *x);
    }
    bool is_good = x != NULL;
    for (int32_t i = 0; is_good && i < nodes; ++i) {
        is_good = next_row(text, x[i]);
        ss_scale3(x[i], x[i], metres_per_unit);
    }
    if (is_good && next_field(text, "Triangles", 1, ss_text_left(text) / MIN_LINE, &faces)) {
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
