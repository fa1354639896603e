/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Running softsim-mesh in a folder of its own. Include after cmocka.h. */
#include "mesh/mesh.h"

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

static char folder[] = "/tmp/softsim-tool-XXXXXX";

#include "folder_fixture.h"

static inline const char *in_folder(const char *name)
{
    static char path[4][256];
    static int turn;
    turn = (turn + 1) % 4;
    (void)snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
    return path[turn];
}

static inline void write_text(const char *name, const char *text)
{
    FILE *file = fopen(in_folder(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

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

static inline ss_mesh *load(const char *name, double unit)
{
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    if (ss_mesh_load(in_folder(name), unit, BIN_DIR "/softsim-import", &mesh, &error) !=
        SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return mesh;
}
