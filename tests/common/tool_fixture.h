/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Meshes in files, and softsim-mesh run on them in a folder of its own: shared by the tests of
 * files and of the tool. cmocka comes first. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "folder_fixture.h"
#include "mesh_fixture.h"

#define TOOL BIN_DIR "/softsim-mesh "

static const char importer[] = BIN_DIR "/softsim-import";

/* Runs a shell command in the folder; its output, both streams, in `out`. Returns its exit status.
 */
static inline int run(const char *command, char *out, size_t size)
{
    char line[2048];
    (void)snprintf(line, sizeof line, "cd %s && %s 2>&1", folder, command);
    FILE *pipe = popen(line, "r");
    assert_non_null(pipe);
    const size_t used = fread(out, 1, size - 1, pipe);
    out[used] = '\0';
    const int status = pclose(pipe);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

/* softsim-mesh with these arguments: what it says, and that it is content. */
__attribute__((format(printf, 1, 2))) static inline void run_tool(const char *format, ...)
{
    char command[1024] = TOOL, out[8192];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(command + strlen(TOOL), sizeof command - strlen(TOOL), format, arguments);
    va_end(arguments);
    if (run(command, out, sizeof out) != 0) {
        fail_msg("%s: %s", command, out);
    }
}

/* What softsim-mesh is given, its exit status, and a part of what it says. */
typedef struct tool_row {
    const char *arguments;
    int status;
    const char *says;
} tool_row;

static inline void expect_answers(const tool_row *row, int32_t count)
{
    for (int32_t i = 0; i < count; ++i) {
        char command[1024], out[8192];
        (void)snprintf(command, sizeof command, TOOL "%s", row[i].arguments);
        const int status = run(command, out, sizeof out);
        if (status != row[i].status || strstr(out, row[i].says) == NULL) {
            fail_msg("%s: %d: %s", row[i].arguments, status, out);
        }
    }
}

static inline ss_mesh *load(const char *path, double unit)
{
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    if (ss_mesh_load(path, unit, importer, &mesh, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return mesh;
}
