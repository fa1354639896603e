/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Options: p fills a piecewise linear surface, Y keeps its triangles, q1.4/10 asks for radius-edge
 * ratios below 1.4 and dihedral angles above 10 degrees where Y lets them, a bounds the volume, z
 * counts from 0, F leaves out faces, which nobody reads, Q is quiet.
 */
#include "tetgen.h"

#include "rt/memory.h"
#include "rt/vec.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

extern char **environ;

enum { PATH_ROOM = 512 };

typedef struct job {
    const ss_mesh *surface;
    softsim_error *error;
    char folder[PATH_ROOM - 32];
} job;

static void path_in(const job *j, const char *name, char out[PATH_ROOM])
{
    (void)snprintf(out, PATH_ROOM, "%s/%s", j->folder, name);
}

static softsim_status fail_system(const job *j, const char *what)
{
    softsim_error_add(j->error, SOFTSIM_ERROR_SYSTEM,
                      "tetgen: %s in %s (%s): check the folder, or "
                      "set TMPDIR to another",
                      what, j->folder, strerror(errno));
    return SOFTSIM_ERROR_SYSTEM;
}

/* ---- the surface ---- */

/* A part of the surface that encloses a negative volume is a cavity's: writes a point just inside
 * each of them. part: the lowest node of each node's part. */
static void write_holes(FILE *file, const ss_mesh *m, const int32_t *part, double *volume)
{
    int32_t count = 0;
    for (int32_t t = 0; t < m->triangle_count; ++t) {
        const int32_t *n = m->triangle[t];
        double across[3];
        ss_cross3(across, m->position[n[1]], m->position[n[2]]);
        volume[part[n[0]]] += ss_dot3(m->position[n[0]], across);
    }
    for (int32_t i = 0; i < m->node_count; ++i) {
        count += volume[i] < 0.0;
    }
    (void)fprintf(file, "%d\n", count);
    count = 0;
    for (int32_t t = 0; t < m->triangle_count; ++t) {
        const int32_t *n = m->triangle[t];
        if (volume[part[n[0]]] < 0.0) {
            volume[part[n[0]]] = 0.0;
            double ab[3], ac[3], out[3], x[3];
            ss_sub3(ab, m->position[n[1]], m->position[n[0]]);
            ss_sub3(ac, m->position[n[2]], m->position[n[0]]);
            ss_cross3(out, ab, ac);
            const double size = sqrt(ss_normalize3(out));
            ss_madd3(x, m->position[n[0]], 1.0 / 3.0, ab);
            ss_madd3(x, x, 1.0 / 3.0, ac);
            ss_madd3(x, x, 1e-3 * size, out);
            (void)fprintf(file, "%d %.17g %.17g %.17g\n", count++, x[0], x[1], x[2]);
        }
    }
}

/* Numbers every node by the lowest of its part: labels sink over triangles until none changes. */
static void label_parts(const ss_mesh *m, int32_t *part)
{
    bool changes = true;
    for (int32_t i = 0; i < m->node_count; ++i) {
        part[i] = i;
    }
    while (changes) {
        changes = false;
        for (int32_t t = 0; t < m->triangle_count; ++t) {
            const int32_t *n = m->triangle[t];
            int32_t least = part[n[0]] < part[n[1]] ? part[n[0]] : part[n[1]];
            least = part[n[2]] < least ? part[n[2]] : least;
            least = part[least] < least ? part[least] : least;
            for (int k = 0; k < 3; ++k) {
                changes = changes || part[n[k]] != least;
                part[n[k]] = least;
            }
        }
    }
}

static softsim_status write_surface(const job *j)
{
    const ss_mesh *m = j->surface;
    char path[PATH_ROOM];
    path_in(j, "in.smesh", path);
    FILE *file = fopen(path, "wx");
    int32_t *part = ss_memory_get((size_t)m->node_count, sizeof *part);
    double *volume = ss_memory_get((size_t)m->node_count, sizeof *volume);
    bool is_good = file != NULL && part != NULL && volume != NULL;
    if (is_good) {
        (void)fprintf(file, "%d 3 0 0\n", m->node_count);
        for (int32_t i = 0; i < m->node_count; ++i) {
            const double *x = m->position[i];
            (void)fprintf(file, "%d %.17g %.17g %.17g\n", i, x[0], x[1], x[2]);
        }
        (void)fprintf(file, "%d 0\n", m->triangle_count);
        for (int32_t t = 0; t < m->triangle_count; ++t) {
            const int32_t *n = m->triangle[t];
            (void)fprintf(file, "3 %d %d %d\n", n[0], n[1], n[2]);
        }
        label_parts(m, part);
        write_holes(file, m, part, volume);
        (void)fprintf(file, "0\n");
        is_good = ferror(file) == 0;
    }
    ss_memory_free(part);
    ss_memory_free(volume);
    if (file != NULL && fclose(file) != 0) {
        is_good = false;
    }
    return is_good ? SOFTSIM_OK : fail_system(j, "cannot write its input");
}

/* ---- the program ---- */

/* Waits at most `timeout_s`; false when the time was up and it was killed. */
static bool wait_for(pid_t pid, double timeout_s, int *out_status)
{
    const struct timespec nap = {.tv_nsec = 5000000};
    struct timespec start;
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &start);
    for (;;) {
        const pid_t ended = waitpid(pid, out_status, WNOHANG);
        if (ended == pid) {
            return true;
        }
        (void)clock_gettime(CLOCK_MONOTONIC, &now);
        if ((ended < 0 && errno != EINTR) ||
            (double)(now.tv_sec - start.tv_sec) + 1e-9 * (double)(now.tv_nsec - start.tv_nsec) >
                timeout_s) {
            (void)kill(pid, SIGKILL);
            (void)waitpid(pid, out_status, 0);
            return false;
        }
        (void)nanosleep(&nap, NULL);
    }
}

/* The last line that is not blank of what it said. */
static void read_last_line(const job *j, char *out, size_t size)
{
    char path[PATH_ROOM];
    char line[256];
    path_in(j, "log", path);
    (void)snprintf(out, size, "it gave no reason");
    FILE *file = fopen(path, "r");
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        line[strcspn(line, "\r\n")] = '\0';
        if (strspn(line, " \t") != strlen(line)) {
            (void)snprintf(out, size, "%s", line);
        }
    }
    if (file != NULL) {
        (void)fclose(file);
    }
}

static softsim_status judge(const job *j, bool is_in_time, int status, double timeout_s)
{
    char line[256];
    if (!is_in_time) {
        softsim_error_add(
            j->error, SOFTSIM_ERROR_SYSTEM,
            "tetgen was not done after %g s and was stopped: ask for longer edges, or "
            "more time with --timeout-s",
            timeout_s);
    } else if (WIFSIGNALED(status)) {
        softsim_error_add(
            j->error, SOFTSIM_ERROR_SYSTEM,
            "tetgen crashed (signal %d): see softsim-mesh check, and mend the surface",
            WTERMSIG(status));
    } else {
        read_last_line(j, line, sizeof line);
        softsim_error_add(j->error, SOFTSIM_ERROR_SYSTEM,
                          "tetgen failed with exit status %d: %s: see softsim-mesh check, and mend "
                          "the surface",
                          WEXITSTATUS(status), line);
    }
    return SOFTSIM_ERROR_SYSTEM;
}

static softsim_status run(const job *j, double volume, double timeout_s)
{
    char options[64];
    char input[PATH_ROOM];
    char log[PATH_ROOM];
    (void)snprintf(options, sizeof options, "-pYzQFq1.4/10a%.17g", volume);
    path_in(j, "in.smesh", input);
    path_in(j, "log", log);
    char name[] = "tetgen";
    char *argv[] = {name, options, input, NULL};
    posix_spawn_file_actions_t actions;
    if (posix_spawn_file_actions_init(&actions) != 0) {
        return fail_system(j, "cannot prepare to start it");
    }
    (void)posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    (void)posix_spawn_file_actions_addopen(&actions, 1, log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    (void)posix_spawn_file_actions_adddup2(&actions, 1, 2);
    pid_t pid = -1;
    const int failure = posix_spawnp(&pid, name, &actions, NULL, argv, environ);
    (void)posix_spawn_file_actions_destroy(&actions);
    if (failure != 0) {
        softsim_error_add(j->error, SOFTSIM_ERROR_SYSTEM,
                          "the program tetgen cannot be started (%s): install Debian's package "
                          "tetgen (apt install tetgen)",
                          strerror(failure));
        return SOFTSIM_ERROR_SYSTEM;
    }
    int status = 0;
    const bool is_in_time = wait_for(pid, timeout_s, &status);
    return is_in_time && WIFEXITED(status) && WEXITSTATUS(status) == 0
               ? SOFTSIM_OK
               : judge(j, is_in_time, status, timeout_s);
}

/* The surface's nodes must be the first, where they were. */
static softsim_status read_result(const job *j, ss_mesh **out)
{
    char path[PATH_ROOM];
    path_in(j, "in.1.node", path);
    const softsim_status status = ss_mesh_load(path, 1.0, NULL, out, j->error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const double reach = 1e-9 * ss_mesh_diagonal(j->surface);
    bool is_kept = (*out)->tetrahedron_count > 0 && (*out)->node_count >= j->surface->node_count;
    for (int32_t i = 0; i < j->surface->node_count && is_kept; ++i) {
        double d[3];
        ss_sub3(d, (*out)->position[i], j->surface->position[i]);
        is_kept = ss_norm3(d) <= reach;
    }
    if (!is_kept) {
        ss_mesh_destroy(out);
        softsim_error_add(
            j->error, SOFTSIM_ERROR_MESH,
            "tetgen did not keep the nodes of the surface: see softsim-mesh check, and "
            "mend it");
        return SOFTSIM_ERROR_MESH;
    }
    return SOFTSIM_OK;
}

static void remove_folder(const job *j)
{
    static const char *const names[] = {"in.smesh",  "in.1.node",  "in.1.ele", "in.1.face",
                                        "in.1.edge", "in.1.smesh", "log"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        char path[PATH_ROOM];
        path_in(j, names[i], path);
        (void)unlink(path);
    }
    (void)rmdir(j->folder);
}

softsim_status tetgen_fill(const ss_mesh *surface, double volume, double timeout_s, ss_mesh **out,
                           softsim_error *error)
{
    job j = {.surface = surface, .error = error};
    *out = NULL;
    const char *place = getenv("TMPDIR");
    const int length = snprintf(j.folder, sizeof j.folder, "%s/softsim-tetgen-XXXXXX",
                                place != NULL && place[0] == '/' ? place : "/tmp");
    if (length < 0 || (size_t)length >= sizeof j.folder || mkdtemp(j.folder) == NULL) {
        return fail_system(&j, "cannot make a folder");
    }
    softsim_status status = write_surface(&j);
    status = status == SOFTSIM_OK ? run(&j, volume, timeout_s) : status;
    status = status == SOFTSIM_OK ? read_result(&j, out) : status;
    remove_folder(&j);
    return status;
}
