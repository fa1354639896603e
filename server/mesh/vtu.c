/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Reader of VTK's XML unstructured grids (.vtu) whose arrays are inline ASCII ("VTK File Formats",
 * XML formats):
 *
 *   <VTKFile type="UnstructuredGrid"> <UnstructuredGrid>
 *     <Piece NumberOfPoints="n" NumberOfCells="m">
 *       <PointData> <DataArray type="Int32" Name="..." format="ascii"> ... </DataArray> ...
 *       <CellData> ...
 *       <Points> <DataArray type="Float64" NumberOfComponents="3" format="ascii"> ...
 *       <Cells> <DataArray Name="connectivity"> ... "offsets" (of ends) ... "types" ...
 *
 * Only the XML that VTK's writers write: tags, attributes, comments. Declarations (<!DOCTYPE) and
 * with them entities of one's own are refused. Here the tags are gone over once for the places of
 * the arrays; vtk_grid.c reads them.
 */
#include "mesh/readers.h"
#include "mesh/vtk.h"

#include <string.h>

enum { TEXT_SIZE = sizeof((ss_vtk_field *)0)->name };

/* Between which tags: arrays outside of these (field data) do not matter. */
typedef enum place {
    PLACE_NONE,
    PLACE_POINT_DATA,
    PLACE_CELL_DATA,
    PLACE_POINTS,
    PLACE_CELLS
} place;

typedef struct tag {
    ss_text_span name, rest; /* rest: the attributes */
    bool is_end, is_empty;
} tag;

typedef struct reader {
    ss_vtk_grid *grid;
    ss_text *text;
    place place;
    bool has_grid, has_piece, is_done;
    int64_t point_count, cell_count;
} reader;

/* ---- tags ---- */

static bool fault_cut(reader *r)
{
    if (!r->text->has_failed) {
        ss_text_fault(r->text,
                      "the text ends before </VTKFile>: the file is cut off, copy or write "
                      "it again");
    }
    return false;
}

/* Goes behind a comment that starts with what is in `start`. */
static bool skip_comment(reader *r, ss_text_span start)
{
    while (start.end - start.begin < 2 || memcmp(start.end - 2, "--", 2) != 0) {
        if (!ss_text_until(r->text, '>', &start)) {
            return fault_cut(r);
        }
    }
    return true;
}

/* The next tag, behind text and comments. */
static bool next_tag(reader *r, tag *out)
{
    ss_text_span span;
    for (;;) {
        if (!ss_text_skip_to(r->text, '<') || !ss_text_until(r->text, '>', &span)) {
            return fault_cut(r);
        }
        ++span.begin;
        const size_t length = (size_t)(span.end - span.begin);
        if (length >= 3 && memcmp(span.begin, "!--", 3) == 0) {
            span.begin += 3;
            if (!skip_comment(r, span)) {
                return false;
            }
        } else if (length > 0 && *span.begin == '!') {
            ss_text_fault(r->text,
                          "declarations are not read: write the mesh from ParaView or VTK");
            return false;
        } else if (length == 0 || *span.begin != '?') {
            break;
        }
    }
    out->is_end = span.begin < span.end && *span.begin == '/';
    span.begin += out->is_end;
    out->is_empty = span.begin < span.end && span.end[-1] == '/';
    span.end -= out->is_empty;
    if (!ss_span_next_word(&span, &out->name)) {
        ss_text_fault(r->text, "a tag without a name: the file is damaged");
        return false;
    }
    out->rest = span;
    return true;
}

/* The five that XML knows; others stay as they are. */
static void decode_entities(char *text)
{
    static const struct {
        const char *name;
        char character;
    } entities[] = {
        {"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}};
    for (char *c = text; *c != '\0'; ++c) {
        for (size_t i = 0; *c == '&' && i < sizeof entities / sizeof entities[0]; ++i) {
            const size_t length = strlen(entities[i].name);
            if (strncmp(c, entities[i].name, length) == 0) {
                *c = entities[i].character;
                memmove(c + 1, c + length, strlen(c + length) + 1);
                break;
            }
        }
    }
}

/* The text of an attribute, empty when it is not there or longer than TEXT_SIZE allows. */
static void get_attribute(const tag *t, const char *name, char out[TEXT_SIZE])
{
    ss_text_span rest = t->rest;
    out[0] = '\0';
    for (;;) {
        const char *equals = memchr(rest.begin, '=', (size_t)(rest.end - rest.begin));
        ss_text_span key = {.begin = rest.begin, .end = equals != NULL ? equals : rest.begin};
        ss_text_span word;
        rest.begin = equals != NULL ? equals + 1 : rest.end;
        while (rest.begin < rest.end &&
               ss_span_is_blank((ss_text_span){rest.begin, rest.begin + 1})) {
            ++rest.begin;
        }
        const char quote = rest.begin < rest.end ? *rest.begin : '\0';
        if (equals == NULL || (quote != '"' && quote != '\'')) {
            return;
        }
        const char *begin = rest.begin + 1;
        const char *end = memchr(begin, quote, (size_t)(rest.end - begin));
        if (end == NULL) {
            return;
        }
        if (ss_span_next_word(&key, &word) && ss_span_is(word, name)) {
            (void)ss_span_copy((ss_text_span){begin, end}, out, TEXT_SIZE);
            decode_entities(out);
            return;
        }
        rest.begin = end + 1;
    }
}

static bool get_count(const tag *t, const char *name, int64_t *out)
{
    char text[TEXT_SIZE];
    get_attribute(t, name, text);
    return ss_span_integer((ss_text_span){text, text + strlen(text)}, out) && *out >= 0;
}

/* ---- arrays ---- */

static ss_vtk_type find_type(const char *name)
{
    static const struct {
        const char *name;
        ss_vtk_type type;
    } names[] = {{"Int8", SS_VTK_INT8},     {"UInt8", SS_VTK_UINT8},   {"Int16", SS_VTK_INT16},
                 {"UInt16", SS_VTK_UINT16}, {"Int32", SS_VTK_INT32},   {"UInt32", SS_VTK_UINT32},
                 {"Int64", SS_VTK_INT64},   {"UInt64", SS_VTK_UINT64}, {"Float32", SS_VTK_FLOAT},
                 {"Float64", SS_VTK_DOUBLE}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strcmp(name, names[i].name) == 0) {
            return names[i].type;
        }
    }
    return SS_VTK_STRING;
}

/* Goes behind </DataArray>; leaves where its values begin. Keys of information may stand before or
 * behind the values. */
static bool skip_values(reader *r, ss_text_mark *out)
{
    bool has_values = false;
    int32_t depth = 0;
    *out = ss_text_here(r->text);
    for (;;) {
        ss_text_span word;
        const bool is_value = depth == 0 && ss_text_next_word(r->text, &word);
        if (is_value && has_values) {
            ss_text_fault(r->text, "values of an array in two pieces: write them in one");
            return false;
        }
        has_values = has_values || is_value;
        tag t;
        if (!next_tag(r, &t)) {
            return false;
        }
        if (depth == 0 && t.is_end && ss_span_is(t.name, "DataArray")) {
            return true;
        }
        if (depth == 0 && (t.is_end || !ss_span_is(t.name, "InformationKey"))) {
            ss_text_fault(r->text, "</DataArray> expected here: the file is damaged");
            return false;
        }
        depth += t.is_end ? -1 : t.is_empty ? 0 : 1;
        if (depth == 0 && !has_values) {
            *out = ss_text_here(r->text);
        }
    }
}

static bool keep_points(reader *r, const ss_vtk_array *array, int64_t components)
{
    if (components != 3 || array->type == SS_VTK_STRING || r->grid->points.type != SS_VTK_NONE) {
        ss_text_fault(r->text, "one array of points expected, of numbers and 3 components");
        return false;
    }
    r->grid->points = *array;
    r->grid->points.count = 3 * r->point_count;
    return true;
}

static bool keep_cells(reader *r, const ss_vtk_array *array, const char *name)
{
    ss_vtk_section *section = &r->grid->section[0];
    const struct {
        const char *name;
        ss_vtk_array *array;
        int64_t count;
    } arrays[] = {{"connectivity", &section->nodes, -1},
                  {"offsets", &section->offsets, r->cell_count},
                  {"types", &r->grid->types, r->cell_count}};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; ++i) {
        if (strcmp(name, arrays[i].name) != 0) {
            continue;
        }
        if (arrays[i].array->type != SS_VTK_NONE || !ss_vtk_is_integer(array->type)) {
            ss_text_fault(r->text, "one array of %s expected, of integers", name);
            return false;
        }
        *arrays[i].array = *array;
        arrays[i].array->count = arrays[i].count;
    }
    return true;
}

static bool keep_data(reader *r, const ss_vtk_array *array, const char *name, int64_t components)
{
    const bool is_of_cells = r->place == PLACE_CELL_DATA;
    if (components != 1 || !ss_vtk_is_integer(array->type) || name[0] == '\0') {
        return true;
    }
    ss_vtk_array counted = *array;
    counted.count = is_of_cells ? r->cell_count : r->point_count;
    return ss_vtk_add_field(r->grid, &counted, is_of_cells, name);
}

static bool read_array(reader *r, const tag *t)
{
    char format[TEXT_SIZE];
    char type[TEXT_SIZE];
    char name[TEXT_SIZE];
    char text[TEXT_SIZE];
    int64_t components = 1;
    get_attribute(t, "format", format);
    get_attribute(t, "type", type);
    get_attribute(t, "Name", name);
    get_attribute(t, "NumberOfComponents", text);
    if (text[0] != '\0' && (!get_count(t, "NumberOfComponents", &components) || components < 1)) {
        ss_text_fault(r->text, "NumberOfComponents=\"%s\": give a whole number from 1 on", text);
        return false;
    }
    if (format[0] != '\0' && strcmp(format, "ascii") != 0) {
        ss_text_fault(r->text,
                      "arrays of format '%s' are not read: write the file with data mode ASCII "
                      "(ParaView: Save Data, Data Mode Ascii; VTK: SetDataModeToAscii)",
                      format);
        return false;
    }
    const bool is_empty = t->is_empty;
    ss_vtk_array array = {.type = find_type(type)};
    array.at = ss_text_here(r->text);
    if (!is_empty && !skip_values(r, &array.at)) {
        return false;
    }
    switch (r->place) {
    case PLACE_POINTS:
        return keep_points(r, &array, components);
    case PLACE_CELLS:
        return keep_cells(r, &array, name);
    case PLACE_POINT_DATA:
    case PLACE_CELL_DATA:
        return keep_data(r, &array, name, components);
    default:
        return true;
    }
}

/* ---- the file ---- */

static bool begin_file(reader *r, const tag *t)
{
    char type[TEXT_SIZE];
    get_attribute(t, "type", type);
    if (strcmp(type, "UnstructuredGrid") != 0) {
        ss_text_fault(
            r->text,
            "a VTK file of type '%s' is not read: write it as UnstructuredGrid (.vtu), or "
            "as legacy VTK",
            type);
        return false;
    }
    r->has_grid = true;
    return true;
}

static bool begin_piece(reader *r, const tag *t)
{
    if (r->has_piece) {
        ss_text_fault(r->text, "a second piece: write the mesh in one (ParaView: Merge Blocks)");
        return false;
    }
    r->has_piece = true;
    if (!get_count(t, "NumberOfPoints", &r->point_count) ||
        !get_count(t, "NumberOfCells", &r->cell_count)) {
        ss_text_fault(r->text, "a piece without good NumberOfPoints and NumberOfCells");
        return false;
    }
    if (r->cell_count > SS_DRAFT_MAX_COUNT || r->point_count > SS_DRAFT_MAX_COUNT ||
        !ss_vtk_has_room(r->grid, SS_VTK_DOUBLE, 3 * r->point_count, "the points") ||
        !ss_vtk_has_room(r->grid, SS_VTK_INT32, 2 * r->cell_count, "the cells")) {
        if (r->text->fault_count == 0) {
            ss_text_fault(r->text, "more than 67 million points or cells are not read: simplify "
                                   "the mesh first");
        }
        return false;
    }
    r->grid->section[0] =
        (ss_vtk_section){.cell_type = SS_VTK_ANY_TYPE, .cell_count = r->cell_count};
    r->grid->section_count = 1;
    return true;
}

static bool handle_end(reader *r, const tag *t)
{
    r->is_done = ss_span_is(t->name, "VTKFile");
    r->place = PLACE_NONE;
    return true;
}

static bool handle_tag(reader *r, const tag *t)
{
    static const struct {
        const char *name;
        place place;
    } places[] = {{"PointData", PLACE_POINT_DATA},
                  {"CellData", PLACE_CELL_DATA},
                  {"Points", PLACE_POINTS},
                  {"Cells", PLACE_CELLS}};
    if (t->is_end) {
        return handle_end(r, t);
    }
    if (ss_span_is(t->name, "VTKFile")) {
        return begin_file(r, t);
    }
    if (!r->has_grid) {
        ss_text_fault(r->text, "<VTKFile type=\"UnstructuredGrid\"> expected here");
        return false;
    }
    if (ss_span_is(t->name, "AppendedData")) {
        ss_text_fault(r->text, "appended data are not read: write the file with data mode ASCII "
                               "(ParaView: Save Data, Data Mode Ascii; VTK: SetDataModeToAscii)");
        return false;
    }
    if (ss_span_is(t->name, "Piece")) {
        return begin_piece(r, t);
    }
    if (ss_span_is(t->name, "DataArray")) {
        return read_array(r, t);
    }
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        if (ss_span_is(t->name, places[i].name) && !t->is_empty) {
            if (!r->has_piece) {
                ss_text_fault(r->text, "<%s> before <Piece>: the file is damaged", places[i].name);
                return false;
            }
            r->place = places[i].place;
        }
    }
    return true;
}

static bool read_file(reader *r)
{
    while (!r->is_done) {
        tag t;
        if (!next_tag(r, &t) || !handle_tag(r, &t)) {
            return false;
        }
    }
    const ss_vtk_section *section = &r->grid->section[0];
    if (!r->has_piece || section->nodes.type == SS_VTK_NONE ||
        section->offsets.type == SS_VTK_NONE) {
        ss_text_fault_file(r->text, SOFTSIM_ERROR_FORMAT,
                           "no piece with connectivity and offsets of cells in it: it is no mesh");
        return false;
    }
    return true;
}

softsim_status ss_mesh_parse_vtu(ss_text *text, double metres_per_unit, ss_mesh **out_mesh)
{
    *out_mesh = NULL;
    reader r = {.text = text, .grid = ss_vtk_create(text)};
    text->stop = '<';
    if (r.grid != NULL) {
        r.grid->is_xml = true;
        if (read_file(&r)) {
            (void)ss_vtk_make_mesh(r.grid, metres_per_unit, out_mesh);
        }
    }
    ss_vtk_destroy(&r.grid);
    return text->status;
}

static bool sniff(const char *start)
{
    return *start == '<' && strstr(start, "<VTKFile") != NULL;
}

static softsim_status read_mesh(const ss_mesh_file *file, ss_mesh **out_mesh)
{
    return ss_mesh_read_text(file, ss_mesh_parse_vtu, out_mesh);
}

extern const ss_mesh_reader ss_mesh_reader_vtu;
const ss_mesh_reader ss_mesh_reader_vtu = {
    .name = "VTK's .vtu (ASCII)", .sniff = sniff, .read = read_mesh};
