/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Meshes in files, and softsim-mesh run on them in a folder of its own: shared by the tests of
 * files and of the tool. cmocka comes first. */
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

static inline ss_mesh *load(const char *path, double unit)
{
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    if (ss_mesh_load(path, unit, importer, &mesh, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return mesh;
}
