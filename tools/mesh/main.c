/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "command.h"
#include "rt/args.h"
#include "rt/plain.h"
#include "rt/program.h"

#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    int (*run)(int argc, char **argv);
    char title[32]; /* becomes argv[0], in a copy */
    const char *about;
} commands[] = {
    {"info", command_info, "softsim-mesh info", "prints what is in a mesh file"},
    {"check", command_check, "softsim-mesh check", "tells whether a mesh can be simulated"},
    {"convert", command_convert, "softsim-mesh convert", "to another format; mends on demand"},
    {"remesh", command_remesh, "softsim-mesh remesh", "evens a surface out; no more slivers"},
    {"tetrahedralize", command_tetrahedralize, "softsim-mesh tetrahedralize",
     "fills a closed surface, by tetgen"},
    {"scene", command_scene, "softsim-mesh scene",
     "writes a scene of a mesh and a tissue, and presses it"},
    {"generate", command_generate, "softsim-mesh generate", "writes a kidney, liver, block ..."},
};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static void print_usage(FILE *out)
{
    (void)fprintf(out, "usage: softsim-mesh COMMAND ...\n"
                       "Makes and examines meshes before they reach a scene. Reads OBJ, STL, PLY, "
                       "GLB, OFF, Gmsh MSH, TetGen and VTK;\nhexahedra, prisms and pyramids become "
                       "tetrahedra.\n\n");
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        (void)fprintf(out, "  %-14s %s; softsim-mesh %s --help\n", commands[i].name,
                      commands[i].about, commands[i].name);
    }
    (void)fprintf(out, "  %-14s prints this\n  %-14s prints the version\n", "--help", "--version");
}

static void print_unknown(const char *name)
{
    char names[16 * COMMAND_COUNT] = "";
    size_t at = 0;
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        at += (size_t)snprintf(names + at, sizeof names - at, "%s%s", i > 0 ? ", " : "",
                               commands[i].name);
    }
    ss_plain_print(stderr, "softsim-mesh: '%s' is not one of %s; softsim-mesh --help says more\n",
                   name, names);
}

static int run(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    if (ss_args_is_answered("softsim-mesh", name, print_usage)) {
        return 0;
    }
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        if (strcmp(name, commands[i].name) == 0) {
            char title[sizeof commands[i].title];
            memcpy(title, commands[i].title, sizeof title);
            argv[1] = title;
            return commands[i].run(argc - 1, argv + 1);
        }
    }
    print_unknown(name);
    return 2;
}

int main(int argc, char **argv)
{
    ss_program_begin();
    return ss_program_finish("softsim-mesh", run(argc, argv));
}
