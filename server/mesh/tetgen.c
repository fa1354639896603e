/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Reader of TetGen's text files (TetGen's manual, "File formats"), '#' to the end of a line being
 * a comment:
 *
 *   .node: points 3 attribute-count has-marker / number x y z attribute ... [marker] ...
 *   .ele:  tetrahedra 4 region-count / number node node node node [region] ...
 *
 * With -o2 tetrahedra have 10 nodes, corners first (second_order.h: the others).
 *
 * TetGen numbers from 0 or from 1, as its first point says; here any numbers do, with gaps. The
 * points' markers name the groups marker=VALUE, the regions region=VALUE. Zero is a value too: a
 * file that marks nothing says so.
 */
#include "mesh/draft.h"
#include "mesh/readers.h"
#include "mesh/second_order.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum {
    MIN_NODE = 7,    /* bytes of the shortest line, "1 0 0 0" */
    MIN_ELEMENT = 9, /* "1 0 1 2 3" */
    MAX_COLUMNS = 64 /* of attributes */
};
/* Regions beyond are not exact in a double. */
static const double max_region = 1e15;

typedef struct reader {
    ss_text *text;
    ss_draft *draft;
    ss_draft_field field;
} reader;

/* The next line that is not blank, without its comment. */
static bool next_line(ss_text *text, ss_text_span *out)
{
    while (ss_text_next_line(text, out)) {
        const char *comment = memchr(out->begin, '#', (size_t)(out->end - out->begin));
        out->end = comment != NULL ? comment : out->end;
        if (!ss_span_is_blank(*out)) {
            return true;
        }
    }
    return false;
}

/* The first line: `count` numbers, of which those after the first may be left out. */
static bool read_head(reader *r, const char *what, int count, int64_t *out)
{
    ss_text_span line;
    bool is_good = next_line(r->text, &line) && ss_span_next_int64(&line, &out[0]) && out[0] >= 0;
    for (int k = 1; k < count && is_good && !ss_span_is_blank(line); ++k) {
        is_good = ss_span_next_int64(&line, &out[k]);
    }
    if (!is_good || !ss_span_is_blank(line)) {
        ss_text_fault(r->text, "%s expected here: it is no TetGen file", what);
        return false;
    }
    return true;
}

static bool has_room(reader *r, int64_t count, int64_t least, const char *what)
{
    if (count > ss_text_left(r->text) / least + 1) {
        return ss_text_fault_short(r->text, count, "", what);
    }
    return true;
}

static bool fault_cut(reader *r, const char *what, int64_t index, int64_t count)
{
    ss_text_fault(r->text, "the text ends at %s %lld of %lld: the file is cut off", what,
                  (long long)index, (long long)count);
    return false;
}

/* As many rows as the first line announces, and nothing after them. */
static bool read_rows(reader *r, bool (*read_row)(reader *r, int64_t index, const int64_t *head),
                      const int64_t *head, const char *what)
{
    for (int64_t i = 0; i < head[0]; ++i) {
        if (!read_row(r, i, head)) {
            return false;
        }
    }
    ss_text_span line;
    if (next_line(r->text, &line)) {
        ss_text_fault(r->text, "more than the %lld %s announced: correct the first line",
                      (long long)head[0], what);
        return false;
    }
    return true;
}

/* ---- points ---- */

static bool read_node(reader *r, int64_t row, const int64_t *head)
{
    const int32_t index = (int32_t)row;
    ss_text_span line;
    double x[3];
    double skipped = 0.0;
    int64_t marker = 0;
    ss_draft_tag *tag = &r->draft->tag[index];
    if (!next_line(r->text, &line)) {
        return fault_cut(r, "point", index, head[0]);
    }
    bool is_good = ss_span_next_int64(&line, &tag->tag) && tag->tag >= 0;
    for (int k = 0; k < 3 && is_good; ++k) {
        is_good = ss_span_next_number(&line, &x[k]);
    }
    for (int64_t k = 0; k < head[2] && is_good; ++k) {
        is_good = ss_span_next_number(&line, &skipped);
    }
    is_good = is_good && (head[3] == 0 || ss_span_next_int64(&line, &marker));
    if (!is_good || !ss_span_is_blank(line)) {
        ss_text_fault(r->text,
                      "point %d: its number (0 or more), x y z, %lld attributes and %s marker "
                      "expected here",
                      index, (long long)head[2], head[3] != 0 ? "a" : "no");
        return false;
    }
    tag->index = index;
    tag->line = r->text->line;
    ss_draft_set_field(&r->field, index, marker);
    return ss_draft_put_node(r->draft, index, x);
}

static bool mark(reader *r, int32_t group, int32_t count, const int32_t *node)
{
    for (int32_t k = 0; k < count; ++k) {
        if (!ss_draft_mark(r->draft, group, node[k])) {
            return false;
        }
    }
    return true;
}

/* The field's values as groups of nodes: of each by its number, or of those of elements. */
static bool keep(reader *r, const char *name, int32_t first, int32_t count, bool is_of_elements)
{
    const ss_draft *d = r->draft;
    if (!ss_draft_name_field(r->draft, &r->field, name, first)) {
        return false;
    }
    for (int32_t i = 0; i < count; ++i) {
        const int32_t group = ss_draft_field_group(&r->field, i);
        const bool is_kept = group < 0 ? true
                             : is_of_elements
                                 ? mark(r, group, 4, d->tetrahedron[i]) &&
                                       (d->middle == NULL || mark(r, group, 6, d->middle[i]))
                                 : mark(r, group, 1, &i);
        if (!is_kept) {
            return false;
        }
    }
    return true;
}

static bool read_nodes(reader *r)
{
    int64_t head[4] = {0, 3, 0, 0};
    if (!read_head(r, "the numbers of points, of dimensions (3), of attributes and of markers", 4,
                   head)) {
        return false;
    }
    if (head[1] != 3 || head[2] < 0 || head[2] > MAX_COLUMNS || head[3] < 0 || head[3] > 1) {
        ss_text_fault(r->text,
                      "points of %lld dimensions, %lld attributes and %lld markers are not read: "
                      "give 3 dimensions, at most %d attributes and 1 marker",
                      (long long)head[1], (long long)head[2], (long long)head[3], (int)MAX_COLUMNS);
        return false;
    }
    if (!has_room(r, head[0], MIN_NODE, "points") ||
        !ss_draft_make_nodes(r->draft, head[0], true) ||
        !ss_draft_make_field(r->draft, &r->field, head[0])) {
        return false;
    }
    return read_rows(r, read_node, head, "points") && ss_draft_sort_tags(r->draft) &&
           (head[3] == 0 || keep(r, "marker", 0, r->draft->node_count, false));
}

/* ---- tetrahedra ---- */

static void set_region(reader *r, int64_t index, double region)
{
    if (fabs(region) <= max_region && region == floor(region)) {
        ss_draft_set_field(&r->field, index, (int64_t)region);
    } else {
        r->field.names_none = true;
    }
}

static bool read_element(reader *r, int64_t index, const int64_t *head)
{
    ss_text_span line;
    int64_t tag = 0;
    double region = 0.0;
    int32_t node[SS_DRAFT_MAX_NODES] = {0};
    if (!next_line(r->text, &line)) {
        return fault_cut(r, "tetrahedron", index, head[0]);
    }
    bool is_good = ss_span_next_int64(&line, &tag);
    for (int64_t k = 0; k < head[1] && is_good; ++k) {
        is_good = ss_span_next_int64(&line, &tag);
        node[k] = is_good ? ss_draft_find_node(r->draft, tag) : -1;
        if (is_good && node[k] < 0) {
            ss_text_fault(r->text,
                          "tetrahedron %lld: there is no point number %lld: correct it, or give "
                          "the .node file that belongs to it",
                          (long long)index, (long long)tag);
            return r->text->fault_count < SS_TEXT_MAX_FAULTS;
        }
    }
    for (int64_t k = 0; k < head[2] && is_good; ++k) {
        double value = 0.0;
        is_good = ss_span_next_number(&line, &value);
        region = k == 0 ? value : region;
    }
    if (!is_good || !ss_span_is_blank(line)) {
        ss_text_fault(r->text,
                      "tetrahedron %lld: its number, %lld points and %lld regions expected here",
                      (long long)index, (long long)head[1], (long long)head[2]);
        return false;
    }
    set_region(r, index, region);
    return ss_draft_add_element(r->draft,
                                head[1] == 10 ? SS_MESH_TETRAHEDRON_2 : SS_MESH_TETRAHEDRON, node,
                                ss_mesh_edges_of_tetgen);
}

static bool read_elements(reader *r)
{
    int64_t head[3] = {0, 4, 0};
    if (!read_head(r, "the numbers of tetrahedra, of nodes of each (4 or 10) and of regions", 3,
                   head)) {
        return false;
    }
    if ((head[1] != 4 && head[1] != 10) || head[2] < 0 || head[2] > MAX_COLUMNS) {
        ss_text_fault(r->text,
                      "elements of %lld nodes and %lld regions are not read: give tetrahedra of 4 "
                      "nodes, or 10 (tetgen -o2), and at most %d regions",
                      (long long)head[1], (long long)head[2], (int)MAX_COLUMNS);
        return false;
    }
    r->draft->found[head[1] == 10 ? SS_MESH_TETRAHEDRON_2 : SS_MESH_TETRAHEDRON] = head[0];
    if (!has_room(r, head[0], MIN_ELEMENT, "tetrahedra") ||
        !ss_draft_make_elements(r->draft, NULL) ||
        !ss_draft_make_field(r->draft, &r->field, head[0])) {
        return false;
    }
    return read_rows(r, read_element, head, "tetrahedra") && r->text->fault_count == 0 &&
           (head[2] == 0 || keep(r, "region", 1, r->draft->tetrahedron_count, true));
}

softsim_status ss_mesh_parse_tetgen(ss_text *nodes, ss_text *elements, double metres_per_unit,
                                    ss_mesh **out_mesh)
{
    *out_mesh = NULL;
    reader r = {.text = nodes, .draft = ss_draft_create(nodes, metres_per_unit)};
    bool is_read = r.draft != NULL && read_nodes(&r) && nodes->fault_count == 0;
    ss_draft_field_fini(&r.field);
    if (is_read) {
        r.text = elements;
        r.draft->text = elements;
        is_read = read_elements(&r);
        ss_draft_field_fini(&r.field);
    }
    if (is_read) {
        (void)ss_draft_finish(r.draft, out_mesh);
    }
    ss_draft_destroy(&r.draft);
    return nodes->status != SOFTSIM_OK ? nodes->status : elements->status;
}

/* ---- the pair of files ---- */

bool ss_mesh_name_pair(const char *path, char *out, size_t size)
{
    const char *extension = ss_mesh_extension(path);
    const bool is_node = strcasecmp(extension, ".node") == 0;
    const bool is_upper = extension[0] == '.' && (extension[1] == 'N' || extension[1] == 'E');
    if (!is_node && strcasecmp(extension, ".ele") != 0) {
        return false;
    }
    const int length =
        snprintf(out, size, "%.*s%s", (int)(extension - path), path,
                 is_node ? (is_upper ? ".ELE" : ".ele") : (is_upper ? ".NODE" : ".node"));
    return length > 0 && (size_t)length < size;
}

/* Reads the pair of which the file is one. */
static softsim_status read_mesh(const ss_mesh_file *file, ss_mesh **out_mesh)
{
    char other_path[PATH_MAX];
    if (!ss_mesh_name_pair(file->path, other_path, sizeof other_path)) {
        softsim_error_add(file->error, SOFTSIM_ERROR_FILE,
                          "%s: cannot read it (its name is too long): check its name and rights",
                          file->path);
        return SOFTSIM_ERROR_FILE;
    }
    int64_t other_size = 0;
    softsim_status status = SOFTSIM_OK;
    const int other = ss_mesh_open_file(other_path, &other_size, &status, file->error);
    if (other < 0) {
        return status;
    }
    const bool is_node = strcasecmp(ss_mesh_extension(file->path), ".node") == 0;
    ss_text mine, others = {0};
    status = SOFTSIM_ERROR_MEMORY;
    if (ss_text_open(&mine, file->fd, file->size, SS_TEXT_WINDOW, file->path, file->error) &&
        ss_text_open(&others, other, other_size, SS_TEXT_WINDOW, other_path, file->error)) {
        status = ss_mesh_parse_tetgen(is_node ? &mine : &others, is_node ? &others : &mine,
                                      file->metres_per_unit, out_mesh);
    }
    ss_text_fini(&mine);
    ss_text_fini(&others);
    (void)close(other);
    return status;
}

extern const ss_mesh_reader ss_mesh_reader_tetgen;
const ss_mesh_reader ss_mesh_reader_tetgen = {.name = "TetGen's .node and .ele (by the ending)",
                                              .extensions = ".node .ele",
                                              .read = read_mesh};
