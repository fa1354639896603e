/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only, and for readers of your own: what a reader of mesh files is. It is one
 * file that defines an ss_mesh_reader and one row in CMakeLists.txt, ss_mesh_reader(); nothing else
 * names it. A row is chosen by what the file starts with, whatever its name, then by its ending.
 *
 * Our own go over a text that has been opened, add their faults to the text's error (with the line,
 * or the byte of a binary file) and make a mesh in SI units, by a draft (draft.h) where the
 * file has volumes or groups, else by ss_mesh_create. Tests and fuzzers call them with texts in
 * memory.
 */
#include "mesh/mesh.h"
#include "mesh/text.h"

/* A file to be read. */
typedef struct ss_mesh_file {
    const char *path;
    int fd;                /* open, regular */
    int64_t size, text_at; /* bytes; where the text begins, behind a byte order mark */
    double metres_per_unit;
    const char *import_program; /* as for ss_mesh_load */
    softsim_error *error;
} ss_mesh_file;

typedef struct ss_mesh_reader {
    const char *name;       /* for messages about a file that is not of this kind */
    const char *extensions; /* ".node .ele", where they alone tell the format, of any case; NULL */
    /* Is `start`, a file's first 4 kB behind blanks, ended by a zero, of this format? NULL: the
     * ending tells. */
    bool (*sniff)(const char *start);
    softsim_status (*read)(const ss_mesh_file *file, ss_mesh **out_mesh);
} ss_mesh_reader;

/* For `read` of a format that is one text. */
typedef softsim_status ss_mesh_parser(ss_text *text, double metres_per_unit, ss_mesh **out_mesh);
softsim_status ss_mesh_read_text(const ss_mesh_file *file, ss_mesh_parser *parse,
                                 ss_mesh **out_mesh);
/* A further file of the same format: open, or -1 with the fault in file->error. */
int ss_mesh_open_file(const char *path, int64_t *out_size, softsim_status *out_status,
                      softsim_error *error);
/* ".node" of "folder/box.node", "" of what has none; a pointer into `path`. */
const char *ss_mesh_extension(const char *path);

/* ---- entry points of tests and fuzzers ---- */

/* Gmsh MSH, ASCII: versions 1, 2.0 to 2.2 and 4.1. */
ss_mesh_parser ss_mesh_parse_msh;
/* OFF, ASCII. */
ss_mesh_parser ss_mesh_parse_off;
/* Legacy VTK, ASCII or binary. */
ss_mesh_parser ss_mesh_parse_vtk;
/* VTK's XML UnstructuredGrid, ASCII. */
ss_mesh_parser ss_mesh_parse_vtu;
/* TetGen's .node and .ele files. */
softsim_status ss_mesh_parse_tetgen(ss_text *nodes, ss_text *elements, double metres_per_unit,
                                    ss_mesh **out_mesh);
