/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Reader of legacy VTK files ("VTK File Formats", simple legacy formats), ASCII and binary, told
 * by their first line:
 *
 *   # vtk DataFile Version 3.0 / title / ASCII | BINARY / DATASET POLYDATA | UNSTRUCTURED_GRID
 *   POINTS n type / x y z ...
 *   POLYGONS, LINES ... CELLS n size / count node node ... (before version 5)
 *   POLYGONS, LINES ... CELLS n+1 size / OFFSETS type / ... / CONNECTIVITY type / ... (from 5 on)
 *   CELL_TYPES n / type ...
 *   POINT_DATA n, CELL_DATA n, and arrays: SCALARS, FIELD, VECTORS ...
 *
 * A keyword has a line of its own, its data begin on the next; binary data are big-endian. Here
 * the file is gone over once for the places of the arrays that matter; vtk_grid.c reads them.
 */
#include "mesh/vtk.h"
#include "mesh/readers.h"

#include <string.h>
#include <strings.h>

enum { NAME_SIZE = sizeof((ss_vtk_field *)0)->name, MAX_COMPONENTS = 1000 };

typedef struct reader {
    ss_vtk_grid *grid;
    ss_text *text;
    bool has_offsets;   /* the layout since version 5 */
    bool is_polydata;   /* else an unstructured grid */
    bool is_of_cells;   /* the arrays that follow */
    int64_t data_count; /* of points or cells, of the arrays that follow; -1: none yet */
} reader;

/* ---- lines ---- */

static bool fault_expected(reader *r, const char *what)
{
    ss_text_fault(r->text, "%s expected here", what);
    return false;
}

static int hex_digit(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                  : -1;
}

/* Blanks and the like are written %20. Names that are too long name no groups: empty here. */
static bool next_name(ss_text_span *line, char out[NAME_SIZE])
{
    ss_text_span word;
    size_t used = 0;
    out[0] = '\0';
    if (!ss_span_next_word(line, &word)) {
        return false;
    }
    for (const char *c = word.begin; c < word.end; ++c) {
        const bool is_code = *c == '%' && word.end - c > 2 && hex_digit(c[1]) >= 0 &&
                             hex_digit(c[2]) >= 0 && (c[1] != '0' || c[2] != '0');
        if (used + 1 >= NAME_SIZE || *c == '\0') {
            out[0] = '\0';
            return true;
        }
        out[used++] = is_code ? (char)(16 * hex_digit(c[1]) + hex_digit(c[2])) : *c;
        c += is_code ? 2 : 0;
    }
    out[used] = '\0';
    return true;
}

static bool next_type(ss_text_span *line, ss_vtk_type *out)
{
    static const struct {
        const char *name;
        ss_vtk_type type;
    } names[] = {
        {"bit", SS_VTK_BIT},
        {"char", SS_VTK_INT8},
        {"signed_char", SS_VTK_INT8},
        {"unsigned_char", SS_VTK_UINT8},
        {"short", SS_VTK_INT16},
        {"unsigned_short", SS_VTK_UINT16},
        {"int", SS_VTK_INT32},
        {"unsigned_int", SS_VTK_UINT32},
        {"long", SS_VTK_INT64},
        {"unsigned_long", SS_VTK_UINT64},
        {"vtkIdType", SS_VTK_INT32}, /* always written in 32 bits */
        {"vtktypeint8", SS_VTK_INT8},
        {"vtktypeuint8", SS_VTK_UINT8},
        {"vtktypeint16", SS_VTK_INT16},
        {"vtktypeuint16", SS_VTK_UINT16},
        {"vtktypeint32", SS_VTK_INT32},
        {"vtktypeuint32", SS_VTK_UINT32},
        {"vtktypeint64", SS_VTK_INT64},
        {"vtktypeuint64", SS_VTK_UINT64},
        {"float", SS_VTK_FLOAT},
        {"double", SS_VTK_DOUBLE},
        {"string", SS_VTK_STRING},
    };
    ss_text_span word;
    if (ss_span_next_word(line, &word)) {
        for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
            if (ss_span_is_any_case(word, names[i].name)) {
                *out = names[i].type;
                return true;
            }
        }
    }
    return false;
}

/* Within what multiplies without overflow. */
static bool next_count(ss_text_span *line, int64_t *out)
{
    return ss_span_next_int32(line, out) && *out >= 0;
}

/* ---- arrays ---- */

/* Goes over the `count` values that begin on the next line. */
static bool skip_array(reader *r, ss_vtk_type type, int64_t count, const char *what,
                       ss_vtk_array *out)
{
    if (!ss_vtk_has_room(r->grid, type, count, what)) {
        return false;
    }
    *out = (ss_vtk_array){.at = ss_text_here(r->text), .type = type, .count = count};
    bool is_there = true;
    ss_text_span word;
    if (type == SS_VTK_STRING && r->grid->is_binary) {
        ss_text_fault(r->text, "an array of binary strings is not read: remove it, or write the "
                               "file as ASCII");
        return false;
    }
    if (r->grid->is_binary) {
        is_there = ss_text_skip_bytes(r->text, ss_vtk_bytes(type, count));
    } else if (type == SS_VTK_STRING) {
        for (int64_t i = 0; i < count && is_there; ++i) {
            is_there = ss_text_line(r->text, &word);
        }
    } else {
        for (int64_t i = 0; i < count && is_there; ++i) {
            is_there = ss_text_next_word(r->text, &word);
        }
    }
    if (!is_there) {
        ss_text_fault(r->text, "the text ends within %s: the file is cut off", what);
    }
    return is_there;
}

static bool is_number(ss_vtk_type type)
{
    return ss_vtk_is_integer(type) || type == SS_VTK_FLOAT || type == SS_VTK_DOUBLE;
}

static bool read_points(reader *r, ss_text_span line)
{
    int64_t count = 0;
    ss_vtk_type type = SS_VTK_NONE;
    if (r->grid->points.type != SS_VTK_NONE) {
        ss_text_fault(r->text, "%s again: write one mesh per file", "POINTS");
        return false;
    }
    if (!next_count(&line, &count) || !next_type(&line, &type) || !is_number(type) ||
        !ss_span_is_blank(line)) {
        return fault_expected(r, "POINTS, their number and the type of their coordinates, alone on "
                                 "the line,");
    }
    return skip_array(r, type, 3 * count, "the points", &r->grid->points);
}

/* A line such as "OFFSETS vtktypeint64", then the array. */
static bool read_named_array(reader *r, const char *name, int64_t count, ss_vtk_array *out)
{
    ss_text_span line;
    ss_text_span word;
    ss_vtk_type type = SS_VTK_NONE;
    if (!ss_text_next_line(r->text, &line) || !ss_span_next_word(&line, &word) ||
        !ss_span_is_any_case(word, name) || !next_type(&line, &type) || !ss_vtk_is_integer(type) ||
        !ss_span_is_blank(line)) {
        ss_text_fault(r->text, "%s and an integer type expected here", name);
        return false;
    }
    return skip_array(r, type, count, "the cells", out);
}

/* VTK's numbers of the cells in the sections of polygonal data. */
enum { TYPE_VERTICES = 2, TYPE_LINES = 4, TYPE_STRIPS = 6, TYPE_POLYGONS = 7 };

/* Data of cells count vertices, lines, polygons and strips in this order, whatever the file's. */
static int section_rank(int32_t cell_type)
{
    return cell_type == TYPE_STRIPS ? TYPE_POLYGONS + 1 : cell_type;
}

/* A new section at its place; NULL is a fault. */
static ss_vtk_section *add_section(reader *r, int32_t cell_type)
{
    ss_vtk_grid *grid = r->grid;
    int32_t place = 0;
    while (place < grid->section_count &&
           section_rank(grid->section[place].cell_type) < section_rank(cell_type)) {
        ++place;
    }
    if (r->is_polydata == (cell_type == SS_VTK_ANY_TYPE) ||
        (place < grid->section_count && grid->section[place].cell_type == cell_type)) {
        ss_text_fault(r->text, "a section of cells that does not belong here: write one mesh per "
                               "file");
        return NULL;
    }
    memmove(&grid->section[place + 1], &grid->section[place],
            (size_t)(grid->section_count - place) * sizeof grid->section[0]);
    ++grid->section_count;
    grid->section[place] = (ss_vtk_section){.cell_type = cell_type};
    return &grid->section[place];
}

static bool read_section(reader *r, ss_text_span line, int32_t cell_type)
{
    int64_t count = 0;
    int64_t size = 0;
    if (!next_count(&line, &count) || !next_count(&line, &size) || !ss_span_is_blank(line)) {
        return fault_expected(r, "the number of cells, and of the numbers that they take,");
    }
    ss_vtk_section *section = add_section(r, cell_type);
    if (section == NULL) {
        return false;
    }
    if (!r->has_offsets) {
        section->cell_count = count;
        return skip_array(r, SS_VTK_INT32, size, "the cells", &section->nodes);
    }
    /* The first number counts the offsets: none for no cells, else one more than cells. */
    section->cell_count = count > 0 ? count - 1 : 0;
    section->has_leading_zero = count > 0;
    return read_named_array(r, "OFFSETS", count, &section->offsets) &&
           read_named_array(r, "CONNECTIVITY", size, &section->nodes);
}

static bool read_cell_types(reader *r, ss_text_span line)
{
    int64_t count = 0;
    if (r->grid->types.type != SS_VTK_NONE) {
        ss_text_fault(r->text, "%s again: write one mesh per file", "CELL_TYPES");
        return false;
    }
    if (!next_count(&line, &count) || !ss_span_is_blank(line)) {
        return fault_expected(r, "the number of types");
    }
    return skip_array(r, SS_VTK_INT32, count, "the cells' types", &r->grid->types);
}

/* ---- data of points and cells ---- */

/* Goes over an array of the data and keeps it where it may name groups. */
static bool read_data(reader *r, const char *name, ss_vtk_type type, int64_t count,
                      int64_t components)
{
    ss_vtk_array array;
    if (count < 0) {
        ss_text_fault(r->text,
                      "an array before POINT_DATA or CELL_DATA: put one of them before it");
        return false;
    }
    if (components < 0 || components > MAX_COMPONENTS) {
        ss_text_fault(r->text, "an array of %lld components: at most %d are read",
                      (long long)components, (int)MAX_COMPONENTS);
        return false;
    }
    if (!skip_array(r, type, count * components, "an array", &array)) {
        return false;
    }
    if (r->data_count < 0 || components != 1 || !ss_vtk_is_integer(type) || name[0] == '\0') {
        return true;
    }
    return ss_vtk_add_field(r->grid, &array, r->is_of_cells, name);
}

static bool begin_data(reader *r, ss_text_span line, bool is_of_cells)
{
    r->is_of_cells = is_of_cells;
    if (!next_count(&line, &r->data_count) || !ss_span_is_blank(line)) {
        return fault_expected(r, "the number of points, or cells, that have data");
    }
    return true;
}

static bool read_scalars(reader *r, ss_text_span line)
{
    char name[NAME_SIZE];
    ss_vtk_type type = SS_VTK_NONE;
    int64_t components = 1;
    if (!next_name(&line, name) || !next_type(&line, &type) ||
        (!ss_span_is_blank(line) && !next_count(&line, &components)) || !ss_span_is_blank(line)) {
        return fault_expected(r, "SCALARS, a name, a type and perhaps a number of components");
    }
    ss_text_span table;
    ss_text_span word;
    if (!ss_text_next_line(r->text, &table) || !ss_span_next_word(&table, &word) ||
        !ss_span_is_any_case(word, "LOOKUP_TABLE")) {
        return fault_expected(r, "LOOKUP_TABLE and its name");
    }
    return read_data(r, name, type, r->data_count, components);
}

static bool read_colours(reader *r, ss_text_span line, bool is_table)
{
    char name[NAME_SIZE];
    int64_t count = 0;
    if (!next_name(&line, name) || !next_count(&line, &count) || !ss_span_is_blank(line)) {
        return fault_expected(r, "a name and a number");
    }
    /* Bytes in binary files, fractions in ASCII: in either no group. */
    return is_table ? read_data(r, "", SS_VTK_UINT8, count, 4)
                    : read_data(r, "", SS_VTK_UINT8, r->data_count, count);
}

/* Also numbers of identity and flags of edges, which are no groups. `components` 0: the line says
 * it. */
static bool read_tuples(reader *r, ss_text_span line, int64_t components)
{
    char name[NAME_SIZE];
    ss_vtk_type type = SS_VTK_NONE;
    if (!next_name(&line, name) || (components == 0 && !next_count(&line, &components)) ||
        !next_type(&line, &type) || !ss_span_is_blank(line)) {
        return fault_expected(r, "a name and a type");
    }
    return read_data(r, "", type, r->data_count, components);
}

static bool skip_metadata(reader *r)
{
    ss_text_span line;
    while (ss_text_line(r->text, &line) && !ss_span_is_blank(line)) {
    }
    return true;
}

/* Is it there, between the arrays of a field too? Takes the line that follows it. */
static bool next_field_line(reader *r, ss_text_span *line)
{
    while (ss_text_next_line(r->text, line)) {
        if (!ss_span_is_any_case(*line, "METADATA")) {
            return true;
        }
        (void)skip_metadata(r);
    }
    return false;
}

static bool read_field(reader *r, ss_text_span line)
{
    char name[NAME_SIZE];
    int64_t count = 0;
    if (!next_name(&line, name) || !next_count(&line, &count) || !ss_span_is_blank(line)) {
        return fault_expected(r, "FIELD, a name and the number of its arrays");
    }
    for (int64_t i = 0; i < count; ++i) {
        int64_t components = 0;
        int64_t tuples = 0;
        ss_vtk_type type = SS_VTK_NONE;
        if (!next_field_line(r, &line) || !next_name(&line, name) ||
            !next_count(&line, &components) || !next_count(&line, &tuples) ||
            !next_type(&line, &type) || !ss_span_is_blank(line)) {
            return fault_expected(r, "an array's name, components, number of values and type");
        }
        if (!read_data(r, name, type, tuples, components)) {
            return false;
        }
    }
    return true;
}

/* ---- the file ---- */

static bool read_dataset(reader *r, ss_text_span line)
{
    ss_text_span word = {0};
    const bool is_named = ss_span_next_word(&line, &word);
    if (is_named && ss_span_is_any_case(word, "POLYDATA")) {
        r->is_polydata = true;
        return true;
    }
    if (is_named && ss_span_is_any_case(word, "UNSTRUCTURED_GRID")) {
        return true;
    }
    ss_text_fault(r->text,
                  "a dataset of kind '%.*s' is not read: write it as UNSTRUCTURED_GRID or POLYDATA "
                  "(in ParaView: Tetrahedralize or Extract Surface, then save)",
                  is_named ? (int)(word.end - word.begin < 40 ? word.end - word.begin : 40) : 0,
                  is_named ? word.begin : "");
    return false;
}

static bool read_header(reader *r)
{
    ss_text_span line;
    double version = 0.0;
    static const char start[] = "# vtk DataFile Version ";
    bool is_good = ss_text_next_line(r->text, &line) &&
                   (size_t)(line.end - line.begin) >= sizeof start &&
                   strncasecmp(line.begin, start, sizeof start - 1) == 0;
    if (is_good) {
        line.begin += sizeof start - 1;
        is_good = ss_span_next_number(&line, &version);
    }
    if (!is_good) {
        return fault_expected(r, "# vtk DataFile Version and its number");
    }
    if (!(version >= 1.0 && version < 6.0)) {
        ss_text_fault(r->text,
                      "a VTK file of version %g is not read: write it as version 3.0 or "
                      "5.1",
                      version);
        return false;
    }
    r->has_offsets = version >= 5.0;
    if (!ss_text_line(r->text, &line) || !ss_text_next_line(r->text, &line) ||
        (!ss_span_is_any_case(line, "ASCII") && !ss_span_is_any_case(line, "BINARY"))) {
        return fault_expected(r, "a title of one line, then ASCII or BINARY alone on a line,");
    }
    r->grid->is_binary = ss_span_is_any_case(line, "BINARY");
    r->text->is_binary = r->grid->is_binary;
    ss_text_span word;
    if (!ss_text_next_line(r->text, &line) || !ss_span_next_word(&line, &word) ||
        !ss_span_is_any_case(word, "DATASET")) {
        return fault_expected(r, "DATASET and its kind");
    }
    return read_dataset(r, line);
}

static bool read_keyword(reader *r, ss_text_span word, ss_text_span line)
{
    static const struct {
        const char *name;
        int32_t value;
    } sections[] = {{"CELLS", SS_VTK_ANY_TYPE},
                    {"POLYGONS", TYPE_POLYGONS},
                    {"VERTICES", TYPE_VERTICES},
                    {"LINES", TYPE_LINES},
                    {"TRIANGLE_STRIPS", TYPE_STRIPS}},
      tuples[] = {
          {"VECTORS", 3},    {"NORMALS", 3},      {"TENSORS", 9},    {"TENSORS6", 6},
          {"GLOBAL_IDS", 1}, {"PEDIGREE_IDS", 1}, {"EDGE_FLAGS", 1}, {"TEXTURE_COORDINATES", 0}};
    for (size_t i = 0; i < sizeof sections / sizeof sections[0]; ++i) {
        if (ss_span_is_any_case(word, sections[i].name)) {
            return read_section(r, line, sections[i].value);
        }
    }
    for (size_t i = 0; i < sizeof tuples / sizeof tuples[0]; ++i) {
        if (ss_span_is_any_case(word, tuples[i].name)) {
            return read_tuples(r, line, tuples[i].value);
        }
    }
    if (ss_span_is_any_case(word, "POINTS")) {
        return read_points(r, line);
    }
    if (ss_span_is_any_case(word, "CELL_TYPES")) {
        return read_cell_types(r, line);
    }
    if (ss_span_is_any_case(word, "POINT_DATA") || ss_span_is_any_case(word, "CELL_DATA")) {
        return begin_data(r, line, ss_span_is_any_case(word, "CELL_DATA"));
    }
    if (ss_span_is_any_case(word, "SCALARS")) {
        return read_scalars(r, line);
    }
    if (ss_span_is_any_case(word, "COLOR_SCALARS") || ss_span_is_any_case(word, "LOOKUP_TABLE")) {
        return read_colours(r, line, ss_span_is_any_case(word, "LOOKUP_TABLE"));
    }
    if (ss_span_is_any_case(word, "FIELD")) {
        return read_field(r, line);
    }
    if (ss_span_is_any_case(word, "METADATA")) {
        return skip_metadata(r);
    }
    ss_text_fault(r->text,
                  "'%.*s' is not a keyword of a legacy VTK file: the count before it does not fit, "
                  "or the file is damaged",
                  (int)(word.end - word.begin < 40 ? word.end - word.begin : 40), word.begin);
    return false;
}

static bool read_file(reader *r)
{
    if (!read_header(r)) {
        return false;
    }
    ss_text_span line;
    while (ss_text_next_line(r->text, &line)) {
        ss_text_span word;
        (void)ss_span_next_word(&line, &word);
        if (!read_keyword(r, word, line)) {
            return false;
        }
    }
    return r->text->fault_count == 0;
}

softsim_status ss_mesh_parse_vtk(ss_text *text, double metres_per_unit, ss_mesh **out_mesh)
{
    *out_mesh = NULL;
    reader r = {.text = text, .grid = ss_vtk_create(text), .data_count = -1};
    if (r.grid != NULL && read_file(&r)) {
        (void)ss_vtk_make_mesh(r.grid, metres_per_unit, out_mesh);
    }
    ss_vtk_destroy(&r.grid);
    return text->status;
}

static bool sniff(const char *start)
{
    static const char head[] = "# vtk DataFile";
    return strncasecmp(start, head, sizeof head - 1) == 0;
}

static softsim_status read_mesh(const ss_mesh_file *file, ss_mesh **out_mesh)
{
    return ss_mesh_read_text(file, ss_mesh_parse_vtk, out_mesh);
}

extern const ss_mesh_reader ss_mesh_reader_vtk;
const ss_mesh_reader ss_mesh_reader_vtk = {
    .name = "VTK (legacy)", .sniff = sniff, .read = read_mesh};
