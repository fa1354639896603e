/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Reader of the Object File Format of Geomview (its manual, "OFF: objects"), ASCII:
 *
 *   [ST][C][N]OFF / vertices faces edges
 *   x y z [normal] [colour] [texture]     a line each
 *   n  v1 ... vn  [colour]                a line each, vertices numbered from 0
 *
 * '#' begins a comment, blank lines do not count, the counts may stand on the first line behind the
 * word, also without a blank, the number of edges may lack, and so may the word itself in a file
 * called .off. Numbers behind a vertex's place or a face's vertices are colours and the like: left
 * out. Faces of four corners stay quads where all are, else they are cut, and so are those of more.
 * "Faces" of one or two vertices are points and lines.
 */
#include "mesh/draft.h"
#include "mesh/polygon.h"
#include "mesh/readers.h"
#include "rt/memory.h"

#include <string.h>

enum { MIN_VERTEX = 6, MIN_FACE = 4 }; /* bytes of the shortest lines, "0 0 0" and "1 0" */

typedef struct reader {
    ss_text *text;
    ss_draft *draft;
    int64_t face_count;
    int32_t corner[SS_POLYGON_CORNERS];
    int32_t piece[SS_POLYGON_CORNERS][3];
} reader;

/* The next line that holds more than a comment. */
static bool next_line(reader *r, ss_text_span *out)
{
    while (ss_text_next_line(r->text, out)) {
        const char *mark = memchr(out->begin, '#', (size_t)(out->end - out->begin));
        out->end = mark != NULL ? mark : out->end;
        if (!ss_span_is_blank(*out)) {
            return true;
        }
    }
    return false;
}

/* Letters of a head before its numbers: "COFF" of "COFF 8 6 12"; none of "8 6 12". */
static ss_text_span take_head(ss_text_span *line)
{
    ss_text_span head = {line->begin, line->begin};
    const char *last = NULL;
    for (const char *at = line->begin; at + 3 <= line->end && at < line->begin + 8; ++at) {
        last = last == NULL && memcmp(at, "OFF", 3) == 0 ? at + 3 : last;
    }
    head.end = last != NULL ? last : head.begin;
    line->begin = head.end;
    return head;
}

/* Forms that are not read, by their heads. */
static bool takes_head(reader *r, ss_text_span head, ss_text_span rest)
{
    ss_text_span word = {rest.begin, rest.begin};
    const bool is_flat = head.end == head.begin || ss_span_is(head, "OFF") ||
                         ss_span_is(head, "COFF") || ss_span_is(head, "NOFF") ||
                         ss_span_is(head, "CNOFF") || ss_span_is(head, "NCOFF") ||
                         ss_span_is(head, "STOFF") || ss_span_is(head, "STCOFF") ||
                         ss_span_is(head, "STNOFF") || ss_span_is(head, "STCNOFF");
    const bool is_binary = ss_span_next_word(&rest, &word) && ss_span_is(word, "BINARY");
    if (!is_flat || is_binary) {
        ss_text_fault(r->text, "%s OFF is not read: write it as ASCII OFF of three coordinates",
                      is_binary ? "binary" : "this kind of");
        return false;
    }
    return true;
}

/* The head and the counts. */
static bool read_head(reader *r)
{
    ss_text_span line;
    int64_t nodes = 0, faces = 0, edges = 0;
    bool is_good = next_line(r, &line);
    if (is_good) {
        const ss_text_span head = take_head(&line);
        if (!takes_head(r, head, line)) {
            return false;
        }
        is_good = !ss_span_is_blank(line) || next_line(r, &line);
    }
    is_good = is_good && ss_span_next_int64(&line, &nodes) && ss_span_next_int64(&line, &faces) &&
              (ss_span_is_blank(line) || ss_span_next_int64(&line, &edges)) &&
              ss_span_is_blank(line) && nodes >= 0 && faces >= 0;
    if (!is_good) {
        ss_text_fault(r->text, "the numbers of vertices, faces and edges expected here");
        return false;
    }
    const int64_t left = ss_text_left(r->text) + 2;
    if (nodes > left / MIN_VERTEX || faces > (left - nodes * MIN_VERTEX) / MIN_FACE) {
        ss_text_fault(r->text,
                      "%lld vertices and %lld faces announced, more than the rest of the file can "
                      "hold: it is damaged or cut off",
                      (long long)nodes, (long long)faces);
        return false;
    }
    r->face_count = faces;
    return ss_draft_make_nodes(r->draft, nodes, false);
}

static bool read_vertices(reader *r)
{
    for (int32_t i = 0; i < r->draft->node_count; ++i) {
        ss_text_span line;
        double x[3];
        if (!next_line(r, &line) || !ss_span_next_number(&line, &x[0]) ||
            !ss_span_next_number(&line, &x[1]) || !ss_span_next_number(&line, &x[2])) {
            ss_text_fault(r->text, "vertex %d of %d: its x y z expected here, on a line of its own",
                          i, r->draft->node_count);
            return false;
        }
        if (!ss_draft_put_node(r->draft, i, x)) {
            return false;
        }
    }
    return r->text->fault_count == 0;
}

/* The next face's line, behind the number of its corners. */
static bool begin_face(reader *r, int64_t face, ss_text_span *out_line, int64_t *out_corners)
{
    if (!next_line(r, out_line) || !ss_span_next_int64(out_line, out_corners) || *out_corners < 1 ||
        *out_corners > SS_POLYGON_CORNERS) {
        ss_text_fault(r->text,
                      "face %lld of %lld: the number of its vertices (1 to %d), then they expected "
                      "here, on a line of its own",
                      (long long)face, (long long)r->face_count, (int)SS_POLYGON_CORNERS);
        return false;
    }
    return true;
}

static ss_mesh_kind kind_of(int64_t corners)
{
    static const ss_mesh_kind kinds[] = {SS_MESH_OTHER, SS_MESH_POINT, SS_MESH_LINE,
                                         SS_MESH_TRIANGLE, SS_MESH_QUAD};
    return corners <= 4 ? kinds[corners] : SS_MESH_TRIANGLE;
}

static bool count_faces(reader *r)
{
    for (int64_t f = 0; f < r->face_count; ++f) {
        ss_text_span line;
        int64_t corners = 0;
        if (!begin_face(r, f, &line, &corners)) {
            return false;
        }
        /* A digit each, and between: a line that announces more is no face. */
        const bool is_long_enough = line.end - line.begin >= 2 * corners - 1;
        r->draft->found[kind_of(corners)] += corners > 4 && is_long_enough ? corners - 2 : 1;
    }
    return true;
}

static bool add_face(reader *r, int corners)
{
    if (corners <= 4) {
        return ss_draft_add_element(r->draft, kind_of(corners), r->corner, NULL);
    }
    ss_mesh_cut_polygon((const double(*)[3])r->draft->position, r->corner, corners, r->piece);
    ++r->draft->cut_count;
    bool is_good = true;
    for (int p = 0; p < corners - 2 && is_good; ++p) {
        is_good = ss_draft_add_element(r->draft, SS_MESH_TRIANGLE, r->piece[p], NULL);
    }
    return is_good;
}

static bool read_face(reader *r, int64_t face)
{
    ss_text_span line;
    int64_t corners = 0;
    if (!begin_face(r, face, &line, &corners)) {
        return false;
    }
    for (int k = 0; k < corners; ++k) {
        int64_t node = 0;
        if (!ss_span_next_int64(&line, &node) || node < 0 || node >= r->draft->node_count) {
            ss_text_fault(r->text, "face %lld: %lld vertices, numbered from 0 to %d, expected here",
                          (long long)face, (long long)corners, r->draft->node_count - 1);
            return r->text->fault_count < SS_TEXT_MAX_FAULTS;
        }
        r->corner[k] = (int32_t)node;
    }
    return add_face(r, (int)corners);
}

static bool read_off(reader *r)
{
    if (!read_head(r) || !read_vertices(r)) {
        return false;
    }
    const ss_text_mark start = ss_text_here(r->text);
    if (!count_faces(r) || !ss_draft_make_elements(r->draft, NULL)) {
        return false;
    }
    ss_text_seek(r->text, start);
    for (int64_t f = 0; f < r->face_count; ++f) {
        if (!read_face(r, f)) {
            return false;
        }
    }
    return r->text->fault_count == 0;
}

softsim_status ss_mesh_parse_off(ss_text *text, double metres_per_unit, ss_mesh **out_mesh)
{
    *out_mesh = NULL;
    reader *r = ss_memory_get(1, sizeof *r);
    if (r == NULL) {
        (void)ss_text_out_of_memory(text);
        return text->status;
    }
    r->text = text;
    r->draft = ss_draft_create(text, metres_per_unit);
    if (r->draft != NULL && read_off(r)) {
        (void)ss_draft_finish(r->draft, out_mesh);
    }
    ss_draft_destroy(&r->draft);
    ss_memory_free(r);
    return text->status;
}

/* Behind comments: OFF, behind letters for what vertices have. */
static bool sniff(const char *start)
{
    while (*start == '#') {
        start += strcspn(start, "\n");
        start += strspn(start, " \t\r\n");
    }
    return strncmp(start + strspn(start, "STCN4n"), "OFF", 3) == 0;
}

static softsim_status read_mesh(const ss_mesh_file *file, ss_mesh **out_mesh)
{
    return ss_mesh_read_text(file, ss_mesh_parse_off, out_mesh);
}

extern const ss_mesh_reader ss_mesh_reader_off;
const ss_mesh_reader ss_mesh_reader_off = {
    .name = "OFF", .extensions = ".off", .sniff = sniff, .read = read_mesh};
