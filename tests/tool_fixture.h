/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Meshes in files, and softsim-mesh run on them in a folder of its own: shared by the tests of
 * files and of the tool. cmocka comes first. */
#include "mesh/mesh.h"

#include "folder_fixture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define TOOL         BIN_DIR "/softsim-mesh "
#define COUNT(array) ((int32_t)(sizeof(array) / sizeof((array)[0])))
#define assert_near(a, b, eps)                                                                     \
    do {                                                                                           \
        const double left_ = (a);                                                                  \
        const double right_ = (b);                                                                 \
        if (!(fabs(left_ - right_) <= (eps))) {                                                    \
            fail_msg("%s = %.17g is not within %g of %.17g", #a, left_, (double)(eps), right_);    \
        }                                                                                          \
    } while (0)

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
