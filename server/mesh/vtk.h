/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Shared by the readers of VTK's formats: where in a file the arrays of a grid are, as vtk.c
 * (legacy) or vtu.c (XML) found them, and what becomes of them (vtk_grid.c). Arrays are read only
 * once all are known: a file may have them in any order.
 */
#include "mesh/draft.h"

enum {
    SS_VTK_MAX_SECTIONS = 4,
    SS_VTK_MAX_FIELDS = 1024, /* arrays of integers that may name groups */
    SS_VTK_ANY_TYPE = -1
};

typedef enum ss_vtk_type {
    SS_VTK_NONE, /* no such array */
    SS_VTK_BIT,
    SS_VTK_INT8,
    SS_VTK_UINT8,
    SS_VTK_INT16,
    SS_VTK_UINT16,
    SS_VTK_INT32,
    SS_VTK_UINT32,
    SS_VTK_INT64,
    SS_VTK_UINT64,
    SS_VTK_FLOAT,
    SS_VTK_DOUBLE,
    SS_VTK_STRING
} ss_vtk_type;

typedef struct ss_vtk_array {
    ss_text_mark at;
    ss_vtk_type type;
    int64_t count; /* of values; XML does not say it of the connectivity: -1 */
} ss_vtk_array;

/* A list of cells. */
typedef struct ss_vtk_section {
    int32_t cell_type; /* of all, or SS_VTK_ANY_TYPE: in the grid's `types` */
    int64_t cell_count;
    ss_vtk_array offsets;  /* none: each cell's nodes come behind their count */
    bool has_leading_zero; /* offsets of the cells' beginnings and the last end; else of ends */
    ss_vtk_array nodes;
} ss_vtk_section;

typedef struct ss_vtk_field {
    ss_vtk_array array;
    bool is_of_cells;
    char name[sizeof((ss_mesh_group *)0)->name + 6]; /* room for "group:" before it */
} ss_vtk_field;

typedef struct ss_vtk_grid {
    ss_text *text;
    bool is_binary; /* big-endian arrays */
    bool is_xml;    /* an array ends where the next tag begins */
    ss_vtk_array points, types;
    ss_vtk_section section[SS_VTK_MAX_SECTIONS];
    int32_t section_count;
    ss_vtk_field field[SS_VTK_MAX_FIELDS];
    int32_t field_count;
} ss_vtk_grid;

ss_vtk_grid *ss_vtk_create(ss_text *text);
void ss_vtk_destroy(ss_vtk_grid **grid);
/* Bytes of `count` values in a binary file. */
int64_t ss_vtk_bytes(ss_vtk_type type, int64_t count);
bool ss_vtk_is_integer(ss_vtk_type type);
/* May an array of `count` values follow here? A fault when not. */
bool ss_vtk_has_room(ss_vtk_grid *grid, ss_vtk_type type, int64_t count, const char *what);
/* Keeps an array of integers, one each, that may name groups (those of long names cannot). */
bool ss_vtk_add_field(ss_vtk_grid *grid, const ss_vtk_array *array, bool is_of_cells,
                      const char *name);
/* Reads the arrays and makes the mesh. */
softsim_status ss_vtk_make_mesh(ss_vtk_grid *grid, double metres_per_unit, ss_mesh **out_mesh);
