/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The commands of softsim-mesh. argv[0] is "softsim-mesh COMMAND"; each returns the program's
 * exit status.
 */
int command_generate(int argc, char **argv);
int command_info(int argc, char **argv);
int command_check(int argc, char **argv);

/* "mm|cm|dm|m" for the option --units, and metres per unit by its index. */
#define UNITS "mm|cm|dm|m"
double metres_per_unit(int index);
const char *unit_name(int index);
