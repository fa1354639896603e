/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The commands of softsim-mesh. argv[0] is "softsim-mesh COMMAND"; each returns the program's
 * exit status.
 */
#include <stdbool.h>

#include "mesh/mesh.h"
#include "rt/args.h"

int command_check(int argc, char **argv);
int command_convert(int argc, char **argv);
int command_generate(int argc, char **argv);
int command_info(int argc, char **argv);
int command_remesh(int argc, char **argv);
int command_scene(int argc, char **argv);
int command_tetrahedralize(int argc, char **argv);

/* A command that reads its arguments into `what` and works on that: the exit status of either. */
int run_command(int argc, char **argv, void *what,
                ss_args_result (*parse)(int argc, char **argv, void *what, softsim_error *error),
                int (*work)(const void *what, softsim_error *error));
/* Prints the faults of a command that did not end well; its exit status. */
int end_command(int exit_code, const softsim_error *error);

/* "mm|cm|dm|m" for the option --units, and metres per unit by its index. */
#define UNITS "mm|cm|dm|m"
enum { UNIT_COUNT = 4 };
double metres_per_unit(int index);
const char *unit_name(int index);
/* Would a scene take a body of this size? `is_metric`: the report is in metres, else in one of the
 * units above. */
bool is_usable_size(const ss_mesh_report *report, bool is_metric);

/* Does the name of `path` end like a format that there is a writer for, and that keeps
 * tetrahedra where there are some? `option` is what gave the path, for the error. */
bool can_write_mesh(const char *path, const char *option, bool has_tetrahedra,
                    softsim_error *error);
/* Does that format keep positions in single precision only? After can_write_mesh. */
bool is_rounded_by(const char *path);
/* Writes in that format, whole or not at all; only after can_write_mesh. */
softsim_status write_mesh(const ss_mesh *mesh, const char *path, softsim_error *error);
/* "PATH: 9 nodes, 20 tetrahedra of dihedral angles from 45.0 to 90.0 degrees, in mm", one line;
 * `unit` NULL: the one the file had. */
void print_written(const ss_mesh *mesh, const char *path, const char *unit);

/* Puts in its place the same mesh of that order: ss_mesh_raise or ss_mesh_lower; 0: as it is. */
softsim_status change_order(int64_t order, ss_mesh **inout_mesh, softsim_error *error);

/* Copies the groups. `number`: the new number of each node, from 1, 0 where it goes; NULL: the
 * same. False when out of memory. */
bool carry_groups(const ss_mesh *from, const int32_t *number, ss_mesh *to);
