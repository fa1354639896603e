/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * From the arrays of a VTK grid to a mesh: points; cells, over which it goes twice (kinds, then
 * nodes); and arrays of integers, one for each point or cell, of which each value names a group
 * when there are few (draft.h).
 *
 * Cells come in two layouts: counted, "3 a b c  4 a b c d ...", or all nodes in one array
 * (connectivity) beside an array of offsets. The sizes of the cells of the latter are kept in four
 * bytes each, since two arrays cannot be read at once through one window; types in one byte.
 */
#include "mesh/vtk.h"

#include "mesh/readers.h"
#include "mesh/second_order.h"
#include "rt/each.h"
#include "rt/memory.h"

#include <string.h>

typedef struct reader {
    ss_vtk_grid *grid;
    ss_text *text;
    ss_draft *draft;
    int64_t cell_count;
    uint8_t *type;         /* of cells, when the grid has `types` */
    int32_t *size;         /* of cells, when the section has offsets */
    ss_draft_field *field; /* of the grid's fields; points' are empty */
    int32_t *cell_field;   /* which of them mark the nodes of cells */
    int32_t cell_field_count;
} reader;

ss_vtk_grid *ss_vtk_create(ss_text *text)
{
    ss_vtk_grid *grid = ss_memory_get(1, sizeof *grid);
    if (grid == NULL) {
        (void)ss_text_out_of_memory(text);
        return NULL;
    }
    grid->text = text;
    return grid;
}

void ss_vtk_destroy(ss_vtk_grid **grid)
{
    ss_memory_free(*grid);
    *grid = NULL;
}

/* ---- arrays ---- */

static int type_bytes(ss_vtk_type type)
{
    static const int bytes[] = {
        [SS_VTK_INT8] = 1,  [SS_VTK_UINT8] = 1,  [SS_VTK_INT16] = 2,  [SS_VTK_UINT16] = 2,
        [SS_VTK_INT32] = 4, [SS_VTK_UINT32] = 4, [SS_VTK_INT64] = 8,  [SS_VTK_UINT64] = 8,
        [SS_VTK_FLOAT] = 4, [SS_VTK_DOUBLE] = 8, [SS_VTK_STRING] = 1,
    };
    return bytes[type];
}

int64_t ss_vtk_bytes(ss_vtk_type type, int64_t count)
{
    return type == SS_VTK_BIT ? (count + 7) / 8 : count * type_bytes(type);
}

bool ss_vtk_is_integer(ss_vtk_type type)
{
    return type >= SS_VTK_INT8 && type <= SS_VTK_UINT64;
}

bool ss_vtk_has_room(ss_vtk_grid *grid, ss_vtk_type type, int64_t count, const char *what)
{
    const int64_t left = ss_text_left(grid->text);
    /* In ASCII two bytes each, but the last. */
    if (count < 0 || count > SS_DRAFT_MAX_COUNT * (int64_t)16 ||
        (grid->is_binary ? ss_vtk_bytes(type, count) > left : count > left / 2 + 1)) {
        return ss_text_fault_short(grid->text, count, "values of ", what);
    }
    return true;
}

bool ss_vtk_add_field(ss_vtk_grid *grid, const ss_vtk_array *array, bool is_of_cells,
                      const char *name)
{
    if (grid->field_count == SS_VTK_MAX_FIELDS) {
        ss_text_fault(grid->text, "more than %d arrays of integers: remove some",
                      (int)SS_VTK_MAX_FIELDS);
        return false;
    }
    ss_vtk_field *field = &grid->field[grid->field_count++];
    field->array = *array;
    field->is_of_cells = is_of_cells;
    memcpy(field->name, name, strlen(name) + 1);
    return true;
}

static uint64_t big_endian(const unsigned char *bytes, int count)
{
    uint64_t value = 0;
    for (int i = 0; i < count; ++i) {
        value = value << 8 | bytes[i];
    }
    return value;
}

static bool next_integer(const reader *r, ss_vtk_type type, int64_t *out)
{
    if (!r->grid->is_binary) {
        ss_text_span word;
        return ss_text_next_word(r->text, &word) && ss_span_integer(word, out);
    }
    const int size = type_bytes(type);
    const unsigned char *bytes = ss_text_bytes(r->text, size);
    if (bytes == NULL) {
        return false;
    }
    const uint64_t value = big_endian(bytes, size);
    switch (type) {
    case SS_VTK_INT8:
        *out = (int8_t)value;
        return true;
    case SS_VTK_INT16:
        *out = (int16_t)value;
        return true;
    case SS_VTK_INT32:
        *out = (int32_t)value;
        return true;
    default:
        *out = (int64_t)value;
        return type != SS_VTK_UINT64 || value <= INT64_MAX;
    }
}

static bool next_real(const reader *r, ss_vtk_type type, double *out)
{
    if (!r->grid->is_binary) {
        ss_text_span word;
        return ss_text_next_word(r->text, &word) && ss_span_number(word, out);
    }
    if (type == SS_VTK_FLOAT || type == SS_VTK_DOUBLE) {
        const int size = type_bytes(type);
        const unsigned char *bytes = ss_text_bytes(r->text, size);
        if (bytes == NULL) {
            return false;
        }
        const uint64_t value = big_endian(bytes, size);
        const uint32_t half = (uint32_t)value;
        float narrow;
        memcpy(&narrow, &half, sizeof narrow);
        memcpy(out, &value, sizeof *out);
        *out = size == 4 ? (double)narrow : *out;
        return true;
    }
    int64_t value = 0;
    const bool is_good = next_integer(r, type, &value);
    *out = (double)value;
    return is_good;
}

/* To be called behind the last value of an array. */
static bool ends_array(const reader *r, const char *what)
{
    ss_text_span word;
    if (r->grid->is_xml && ss_text_next_word(r->text, &word)) {
        ss_text_fault(r->text, "more values of %s than there should be: correct the counts", what);
        return false;
    }
    return true;
}

/* ---- points ---- */

static bool read_points(reader *r)
{
    const ss_vtk_array *points = &r->grid->points;
    if (!ss_draft_make_nodes(r->draft, points->count / 3, false)) {
        return false;
    }
    ss_text_seek(r->text, points->at);
    for (int32_t i = 0; i < r->draft->node_count; ++i) {
        double x[3];
        for (int k = 0; k < 3; ++k) {
            if (!next_real(r, points->type, &x[k])) {
                ss_text_fault(r->text, "point %d of %d: its x y z expected here", i,
                              r->draft->node_count);
                return false;
            }
        }
        if (!ss_draft_put_node(r->draft, i, x)) {
            return false;
        }
    }
    return r->text->fault_count == 0 && ends_array(r, "the points");
}

/* ---- cells ---- */

/* Of VTK's cell types (vtkCellType.h): nodes 0 are any. */
static const struct {
    ss_mesh_kind kind;
    int32_t nodes;
} types[] = {
    {SS_MESH_OTHER, 0},          {SS_MESH_POINT, 1},       {SS_MESH_POINT, 0},
    {SS_MESH_LINE, 2},           {SS_MESH_LINE, 0},        {SS_MESH_TRIANGLE, 3},
    {SS_MESH_POLYGON, 0},        {SS_MESH_POLYGON, 0},     {SS_MESH_POLYGON, 4},
    {SS_MESH_QUAD, 4},           {SS_MESH_TETRAHEDRON, 4}, {SS_MESH_HEXAHEDRON, 8},
    {SS_MESH_HEXAHEDRON, 8},     {SS_MESH_PRISM, 6},       {SS_MESH_PYRAMID, 5},
    {SS_MESH_OTHER, 0},          {SS_MESH_OTHER, 0},       {SS_MESH_OTHER, 0},
    {SS_MESH_OTHER, 0},          {SS_MESH_OTHER, 0},       {SS_MESH_OTHER, 0},
    {SS_MESH_LINE_2, 3},         {SS_MESH_TRIANGLE_2, 6},  {SS_MESH_HIGHER_ORDER, 0},
    {SS_MESH_TETRAHEDRON_2, 10},
};
enum {
    TYPE_POLYGON = 7,
    TYPE_VOXEL = 11, /* corners by rows, not around */
    TYPE_COUNT = sizeof types / sizeof types[0],
    FIRST_QUADRATIC = TYPE_COUNT,
    LAST_QUADRATIC = 37,
    FIRST_HIGHER = 60,
    LAST_HIGHER = 81
};

/* The kind of a cell; false when it cannot have so many nodes. */
static bool find_kind(int32_t type, int64_t size, ss_mesh_kind *out)
{
    if (type == TYPE_POLYGON && (size == 3 || size == 4)) {
        *out = size == 3 ? SS_MESH_TRIANGLE : SS_MESH_QUAD;
        return true;
    }
    const bool is_higher = (type >= FIRST_QUADRATIC && type <= LAST_QUADRATIC) ||
                           (type >= FIRST_HIGHER && type <= LAST_HIGHER);
    const bool is_listed = type < TYPE_COUNT;
    *out = is_listed ? types[type].kind : is_higher ? SS_MESH_HIGHER_ORDER : SS_MESH_OTHER;
    return !is_listed || types[type].nodes == 0 || types[type].nodes == size;
}

static bool read_types(reader *r)
{
    const ss_vtk_array *array = &r->grid->types;
    if (array->count != r->cell_count) {
        ss_text_seek(r->text, array->at);
        ss_text_fault(r->text, "%lld types of %lld cells: correct the counts",
                      (long long)array->count, (long long)r->cell_count);
        return false;
    }
    r->type = ss_memory_get((size_t)array->count, sizeof *r->type);
    if (r->type == NULL) {
        return ss_text_out_of_memory(r->text);
    }
    ss_text_seek(r->text, array->at);
    for (int64_t i = 0; i < array->count; ++i) {
        int64_t type = 0;
        if (!next_integer(r, array->type, &type) || type < 0 || type > UINT8_MAX) {
            ss_text_fault(r->text, "cell %lld: its type, a number from 0 to 255, expected here",
                          (long long)i);
            return false;
        }
        r->type[i] = (uint8_t)type;
    }
    return ends_array(r, "the cells' types");
}

/* Differences of the offsets; their last is the number of nodes. */
static bool read_sizes(reader *r, ss_vtk_section *section)
{
    const ss_vtk_array *array = &section->offsets;
    ss_text_seek(r->text, array->at);
    int64_t last = 0;
    for (int64_t i = section->has_leading_zero ? -1 : 0; i < section->cell_count; ++i) {
        int64_t offset = 0;
        if (!next_integer(r, array->type, &offset) || offset < last || offset - last > INT32_MAX ||
            (i < 0 && offset != 0)) {
            ss_text_fault(r->text, "cell %lld: its offset, not less than %lld, expected here",
                          (long long)(i < 0 ? 0 : i), (long long)last);
            return false;
        }
        if (i >= 0) {
            r->size[i] = (int32_t)(offset - last);
        }
        last = offset;
    }
    if (!ends_array(r, "the cells' offsets")) {
        return false;
    }
    ss_text_seek(r->text, section->nodes.at);
    if (section->nodes.count < 0) {
        section->nodes.count = last;
        return ss_vtk_has_room(r->grid, section->nodes.type, last, "the cells' nodes");
    }
    if (last != section->nodes.count) {
        ss_text_fault(r->text, "%lld nodes of cells, but the offsets end at %lld: correct them",
                      (long long)section->nodes.count, (long long)last);
        return false;
    }
    return true;
}

/* The number of nodes of the section's i-th cell, `used` numbers after the section's start. */
static bool next_size(reader *r, const ss_vtk_section *section, int64_t i, int64_t used,
                      int64_t *out)
{
    const int64_t left = section->nodes.count - used;
    if (section->offsets.type != SS_VTK_NONE) {
        *out = r->size[i];
        return true;
    }
    if (left < 1 || !next_integer(r, section->nodes.type, out) || *out < 0 || *out > left - 1) {
        ss_text_fault(r->text,
                      "cell %lld: the number of its nodes, at most %lld here, expected: the "
                      "size in the section's line does not fit, or the file is damaged",
                      (long long)i, (long long)(left > 0 ? left - 1 : 0));
        return false;
    }
    return true;
}

/* `cell` counts over all sections. */
static int32_t type_of(const reader *r, const ss_vtk_section *section, int64_t cell)
{
    return section->cell_type >= 0 ? section->cell_type : r->type[cell];
}

static bool next_kind(reader *r, const ss_vtk_section *section, int64_t cell, int64_t size,
                      ss_mesh_kind *out)
{
    const int32_t type = type_of(r, section, cell);
    if (!find_kind(type, size, out)) {
        ss_text_fault(r->text, "cell %lld, of type %d (%s), has %lld nodes: it must have %d",
                      (long long)cell, type, ss_mesh_kind_name(*out), (long long)size,
                      types[type].nodes);
        return false;
    }
    return true;
}

static bool skip_nodes(reader *r, const ss_vtk_section *section, int64_t count)
{
    if (r->grid->is_binary) {
        return ss_text_skip_bytes(r->text, ss_vtk_bytes(section->nodes.type, count));
    }
    ss_text_span word;
    int64_t i = 0;
    while (i < count && ss_text_next_word(r->text, &word)) {
        ++i;
    }
    return i == count;
}

static bool fault_cut(reader *r, int64_t cell)
{
    ss_text_fault(r->text, "the text ends in cell %lld of %lld: the file is cut off",
                  (long long)cell, (long long)r->cell_count);
    return false;
}

/* Does something with each cell; *out_used: numbers that all have, their counts too. */
typedef bool (*cell_visit)(reader *r, const ss_vtk_section *section, int64_t cell, int64_t size,
                           ss_mesh_kind kind);
static bool each_cell(reader *r, const ss_vtk_section *section, int64_t first_cell,
                      cell_visit visit, int64_t *out_used)
{
    *out_used = 0;
    ss_text_seek(r->text, section->nodes.at);
    for (int64_t i = 0; i < section->cell_count; ++i) {
        int64_t size = 0;
        ss_mesh_kind kind = SS_MESH_OTHER;
        if (!next_size(r, section, i, *out_used, &size) ||
            !next_kind(r, section, first_cell + i, size, &kind) ||
            !visit(r, section, first_cell + i, size, kind)) {
            return false;
        }
        *out_used += size + (section->offsets.type == SS_VTK_NONE);
    }
    return true;
}

static bool count_cell(reader *r, const ss_vtk_section *section, int64_t cell, int64_t size,
                       ss_mesh_kind kind)
{
    ++r->draft->found[kind];
    return section->offsets.type != SS_VTK_NONE || skip_nodes(r, section, size) ||
           fault_cut(r, cell);
}

static bool count_kinds(reader *r, const ss_vtk_section *section, int64_t first_cell)
{
    int64_t used = 0;
    if (!each_cell(r, section, first_cell, count_cell, &used)) {
        return false;
    }
    if (used != section->nodes.count) {
        ss_text_fault(r->text, "%lld numbers of cells announced, but they have %lld: correct it",
                      (long long)section->nodes.count, (long long)used);
        return false;
    }
    return true;
}

/* Marks a node of a cell in the groups of the cell's values. */
static bool mark_node(reader *r, int64_t cell, int32_t node)
{
    for (int32_t i = 0; i < r->cell_field_count; ++i) {
        const int32_t group = ss_draft_field_group(&r->field[r->cell_field[i]], cell);
        if (group >= 0 && !ss_draft_mark(r->draft, group, node)) {
            return false;
        }
    }
    return true;
}

static void swap_nodes(int32_t *a, int32_t *b)
{
    const int32_t swap = *a;
    *a = *b;
    *b = swap;
}

static bool read_cell(reader *r, const ss_vtk_section *section, int64_t cell, int64_t size,
                      ss_mesh_kind kind)
{
    /* Faces of any kind beside tetrahedra name nodes. */
    const bool is_volume = r->draft->tetrahedron_room > 0;
    const bool is_face = kind == SS_MESH_POLYGON || kind == SS_MESH_TRIANGLE_2;
    const bool names = kind <= SS_MESH_PYRAMID || (is_face && is_volume);
    int32_t node[SS_DRAFT_MAX_NODES] = {0};
    bool is_good = true;
    for (int64_t k = 0; k < size; ++k) {
        int64_t index = 0;
        if (!next_integer(r, section->nodes.type, &index)) {
            ss_text_fault(r->text, "cell %lld: %lld node numbers expected here", (long long)cell,
                          (long long)size);
            return false;
        }
        if (index < 0 || index >= r->draft->node_count) {
            if (is_good) {
                ss_text_fault(r->text,
                              "cell %lld: there is no point %lld: they are numbered from 0 to %d",
                              (long long)cell, (long long)index, r->draft->node_count - 1);
            }
            is_good = false;
            continue;
        }
        if (k < SS_DRAFT_MAX_NODES) {
            node[k] = (int32_t)index;
        }
        if (names && !mark_node(r, cell, (int32_t)index)) {
            return false;
        }
    }
    if (type_of(r, section, cell) == TYPE_VOXEL) {
        swap_nodes(&node[2], &node[3]);
        swap_nodes(&node[6], &node[7]);
    }
    return is_good ? ss_draft_add_element(r->draft, kind, node, ss_mesh_edges_of_vtk)
                   : r->text->fault_count < SS_TEXT_MAX_FAULTS;
}

static bool read_cells(reader *r, const ss_vtk_section *section, int64_t first_cell)
{
    int64_t used = 0;
    return each_cell(r, section, first_cell, read_cell, &used) && ends_array(r, "the cells' nodes");
}

/* Goes over all sections, for kinds or for nodes. The sizes of one at a time are kept. */
static bool go_over_cells(reader *r, bool is_counting)
{
    int64_t first_cell = 0;
    for (int32_t s = 0; s < r->grid->section_count; ++s) {
        ss_vtk_section *section = &r->grid->section[s];
        const bool has_offsets = section->offsets.type != SS_VTK_NONE;
        ss_memory_free(r->size);
        r->size = ss_memory_get(has_offsets ? (size_t)section->cell_count : 0, sizeof *r->size);
        if (r->size == NULL) {
            return ss_text_out_of_memory(r->text);
        }
        if ((has_offsets && !read_sizes(r, section)) ||
            !(is_counting ? count_kinds(r, section, first_cell)
                          : read_cells(r, section, first_cell))) {
            return false;
        }
        first_cell += section->cell_count;
    }
    return true;
}

/* ---- fields ---- */

static bool mark_points(reader *r, const ss_draft_field *field)
{
    for (int32_t i = 0; i < r->draft->node_count; ++i) {
        const int32_t group = ss_draft_field_group(field, i);
        if (group >= 0 && !ss_draft_mark(r->draft, group, i)) {
            return false;
        }
    }
    return true;
}

static bool read_field(reader *r, int32_t f)
{
    const ss_vtk_field *field = &r->grid->field[f];
    const int64_t count = field->is_of_cells ? r->cell_count : r->draft->node_count;
    ss_text_seek(r->text, field->array.at);
    if (field->array.count != count) {
        ss_text_fault(r->text, "%s: %lld values for %lld %s: correct the counts", field->name,
                      (long long)field->array.count, (long long)count,
                      field->is_of_cells ? "cells" : "points");
        return false;
    }
    if (!ss_draft_make_field(r->draft, &r->field[f], count)) {
        return false;
    }
    for (int64_t i = 0; i < count; ++i) {
        int64_t value = 0;
        if (!next_integer(r, field->array.type, &value)) {
            ss_text_fault(r->text, "%s: value %lld of %lld, an integer, expected here", field->name,
                          (long long)i, (long long)count);
            return false;
        }
        ss_draft_set_field(&r->field[f], i, value);
    }
    if (!ends_array(r, field->name) ||
        !ss_draft_name_field(r->draft, &r->field[f], field->name, f) ||
        (!field->is_of_cells && !mark_points(r, &r->field[f]))) {
        return false;
    }
    if (field->is_of_cells && !r->field[f].names_none) {
        r->cell_field[r->cell_field_count++] = f;
    } else {
        ss_draft_field_fini(&r->field[f]);
    }
    return true;
}

static bool read_fields(reader *r)
{
    r->field = ss_memory_get((size_t)r->grid->field_count, sizeof *r->field);
    r->cell_field = ss_memory_get((size_t)r->grid->field_count, sizeof *r->cell_field);
    if (r->field == NULL || r->cell_field == NULL) {
        return ss_text_out_of_memory(r->text);
    }
    for (int32_t f = 0; f < r->grid->field_count; ++f) {
        if (!read_field(r, f)) {
            return false;
        }
    }
    return true;
}

/* ---- the mesh ---- */

static bool read_grid(reader *r)
{
    ss_vtk_grid *grid = r->grid;
    if (grid->points.type == SS_VTK_NONE || grid->section_count == 0) {
        ss_text_fault_file(r->text, SOFTSIM_ERROR_FORMAT,
                           "no %s in it: the file is cut off or not a mesh",
                           grid->points.type == SS_VTK_NONE ? "points" : "cells");
        return false;
    }
    bool has_types = false;
    for (int32_t s = 0; s < grid->section_count; ++s) {
        r->cell_count += grid->section[s].cell_count;
        has_types = has_types || grid->section[s].cell_type == SS_VTK_ANY_TYPE;
    }
    if (has_types && grid->types.type == SS_VTK_NONE) {
        ss_text_fault_file(r->text, SOFTSIM_ERROR_FORMAT,
                           "no types of the cells in it: the file is cut off or not a mesh");
        return false;
    }
    return (!has_types || read_types(r)) && read_points(r) && go_over_cells(r, true) &&
           ss_draft_make_elements(r->draft, NULL) && read_fields(r) && go_over_cells(r, false) &&
           r->text->fault_count == 0;
}

softsim_status ss_vtk_make_mesh(ss_vtk_grid *grid, double metres_per_unit, ss_mesh **out_mesh)
{
    reader r = {.grid = grid, .text = grid->text};
    r.draft = ss_draft_create(grid->text, metres_per_unit);
    const bool is_read = r.draft != NULL && read_grid(&r);
    for (int32_t f = 0; r.field != NULL && f < grid->field_count; ++f) {
        ss_draft_field_fini(&r.field[f]);
    }
    SS_EACH(ss_memory_free, r.field, r.cell_field, r.type, r.size);
    if (is_read) {
        (void)ss_draft_finish(r.draft, out_mesh);
    }
    ss_draft_destroy(&r.draft);
    return grid->text->status;
}
