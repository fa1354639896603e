/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Reading the formats that assimp knows through the helper program softsim-import, because assimp
 * ends the process or never returns on some damaged files. The helper limits its own memory and
 * CPU time; here a clock limits its wall time and its output is bounded and checked, since a
 * damaged file may have made it write anything. A child forked without exec was rejected: the
 * daemon would link assimp.
 */
#include "mesh/import.h"

#include "mesh/mesh.h"
#include "mesh/readers.h"
#include "rt/clock.h"
#include "rt/files.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { MAX_WALL_S = 60, MAX_TEXT = PATH_MAX + 1024 };

typedef struct buffer {
    char *data;
    size_t size, capacity, limit;
} buffer;

typedef struct import {
    const char *path;
    double metres_per_unit;
    softsim_error *error;
    buffer out;          /* what the helper writes */
    char text[MAX_TEXT]; /* the start of what it says on stderr */
    size_t text_size;
    const char *stopped; /* why it was killed by us; NULL: it was not */
} import;

/* ---- the helper program ---- */

/* The file that this code was loaded from, program or library, at its absolute path: of the folder
 * it was installed to, or moved to since. dladdr() was rejected: of a program it gives the name
 * that the caller chose, which may be that of another file in the working directory.
 * Returns 0 or an errno value. */
static int find_own_file(char out[PATH_MAX])
{
    FILE *maps = fopen("/proc/self/maps", "re");
    const int reason = maps != NULL ? ENOENT : errno;
    char line[PATH_MAX + 128];
    bool is_found = false;
    while (maps != NULL && !is_found && fgets(line, sizeof line, maps) != NULL) {
        uintptr_t begin = 0, end = 0;
        int at = 0;
        const int count =
            sscanf(line, "%" SCNxPTR "-%" SCNxPTR " %*s %*s %*s %*s %n", &begin, &end, &at);
        line[strcspn(line, "\n")] = '\0';
        is_found = count == 2 && (uintptr_t)find_own_file >= begin &&
                   (uintptr_t)find_own_file < end && line[at] == '/' &&
                   snprintf(out, PATH_MAX, "%s", line + at) < PATH_MAX;
    }
    if (maps != NULL) {
        (void)fclose(maps);
    }
    return is_found ? 0 : reason;
}

/* The helper that was given, else the one beside this code's own file, as built, or where it is
 * installed by that file's place: never by an absolute path of the build. Returns 0 or an errno
 * value. */
static int find_program(const char *given, char out[PATH_MAX])
{
    static const char *const place[] = {"softsim-import", SOFTSIM_IMPORT_FROM_BIN,
                                        SOFTSIM_IMPORT_FROM_LIB};
    if (given != NULL) {
        return snprintf(out, PATH_MAX, "%s", given) >= PATH_MAX ? ENAMETOOLONG
               : access(out, X_OK) == 0                         ? 0
                                                                : errno;
    }
    char own[PATH_MAX] = "";
    const int reason = find_own_file(own);
    if (reason != 0) {
        return reason;
    }
    const int folder = (int)(strrchr(own, '/') + 1 - own);
    for (size_t i = 0; i < sizeof place / sizeof *place; ++i) {
        if (snprintf(out, PATH_MAX, "%.*s%s", folder, own, place[i]) < PATH_MAX &&
            access(out, X_OK) == 0) {
            return 0;
        }
    }
    return ENOENT;
}

/* A path that begins with '-' must not look like an option. */
static const char *dash_guard(const char *path)
{
    return path[0] == '-' ? "./" : "";
}

/* Starts it with /dev/null as stdin and pipes for the rest; our ends close on exec. Returns 0 or
 * an errno value. */
static int start_program(const char *program, const char *path, pid_t *out_pid, int out_fd[2])
{
    int output[2], errors[2];
    if (pipe2(output, O_CLOEXEC) != 0) {
        return errno;
    }
    if (pipe2(errors, O_CLOEXEC) != 0) {
        const int reason = errno;
        (void)close(output[0]);
        (void)close(output[1]);
        return reason;
    }
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none;
    sigset_t defaults;
    (void)sigemptyset(&none);
    (void)sigemptyset(&defaults);
    (void)sigaddset(&defaults, SIGPIPE);
    (void)sigaddset(&defaults, SIGXCPU);
    (void)posix_spawn_file_actions_init(&actions);
    (void)posix_spawnattr_init(&attributes);
    (void)posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    (void)posix_spawn_file_actions_adddup2(&actions, output[1], 1);
    (void)posix_spawn_file_actions_adddup2(&actions, errors[1], 2);
    (void)posix_spawnattr_setsigmask(&attributes, &none);
    (void)posix_spawnattr_setsigdefault(&attributes, &defaults);
    (void)posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

    char safe_path[PATH_MAX + 2];
    (void)snprintf(safe_path, sizeof safe_path, "%s%s", dash_guard(path), path);
    char program_name[] = "softsim-import";
    char *const arguments[] = {program_name, safe_path, NULL};
    const int reason = posix_spawn(out_pid, program, &actions, &attributes, arguments, environ);
    (void)posix_spawn_file_actions_destroy(&actions);
    (void)posix_spawnattr_destroy(&attributes);
    (void)close(output[1]);
    (void)close(errors[1]);
    if (reason != 0) {
        (void)close(output[0]);
        (void)close(errors[0]);
        return reason;
    }
    out_fd[0] = output[0];
    out_fd[1] = errors[0];
    return 0;
}

/* ---- the importer's answer ---- */

static bool grow(buffer *b)
{
    if (b->size < b->capacity) {
        return true;
    }
    const size_t capacity = b->capacity == 0 ? 1 << 16 : 2 * b->capacity;
    char *data = b->size < b->limit ? realloc(b->data, capacity) : NULL;
    if (data == NULL) {
        return false;
    }
    b->data = data;
    b->capacity = capacity;
    return true;
}

/* Reads what is there; false at the end of the stream (*out_failed: or when it is too much). */
static bool read_output(buffer *b, int fd, bool *out_failed)
{
    if (!grow(b)) {
        *out_failed = true;
        return false;
    }
    const ssize_t count = read(fd, b->data + b->size, b->capacity - b->size);
    if (count > 0) {
        b->size += (size_t)count;
    }
    return count > 0 || (count < 0 && errno == EINTR);
}

static bool read_text(import *im, int fd)
{
    char piece[256];
    const ssize_t count = read(fd, piece, sizeof piece);
    for (ssize_t i = 0; i < count && im->text_size + 1 < sizeof im->text; ++i) {
        im->text[im->text_size++] = piece[i];
    }
    return count > 0 || (count < 0 && errno == EINTR);
}

/* Collects both streams until they end, or time or bounds do. */
static void collect(import *im, const int fd[2])
{
    struct pollfd polled[2] = {{.fd = fd[0], .events = POLLIN}, {.fd = fd[1], .events = POLLIN}};
    const int64_t deadline_ns = ss_clock_now_ns() + (int64_t)MAX_WALL_S * 1000000000;
    bool has_failed = false;
    while (polled[0].fd >= 0 || polled[1].fd >= 0) {
        const int64_t left_ms = (deadline_ns - ss_clock_now_ns()) / 1000000;
        const int ready = left_ms > 0 ? poll(polled, 2, (int)left_ms) : 0;
        if (ready == 0 || (ready < 0 && errno != EINTR)) {
            im->stopped = "took longer than its 60 s";
            return;
        }
        if (ready > 0 && polled[0].revents != 0 && !read_output(&im->out, fd[0], &has_failed)) {
            polled[0].fd = -1;
        }
        if (ready > 0 && polled[1].revents != 0 && !read_text(im, fd[1])) {
            polled[1].fd = -1;
        }
        if (has_failed) {
            im->stopped = "gave more than its 1 GiB";
            return;
        }
    }
}

/* Runs the helper to its end, by force if need be. Returns false when it could not be run. */
static bool run_program(import *im, const char *program, int *out_status)
{
    pid_t pid = 0;
    int fd[2] = {-1, -1};
    const int reason = start_program(program, im->path, &pid, fd);
    if (reason != 0) {
        softsim_error_add(im->error, SOFTSIM_ERROR_SYSTEM, "%s: cannot start %s (%s)", im->path,
                          program, ss_files_reason(reason));
        return false;
    }
    collect(im, fd);
    if (im->stopped != NULL) {
        (void)kill(pid, SIGKILL);
    }
    (void)close(fd[0]);
    (void)close(fd[1]);
    pid_t waited;
    do {
        waited = waitpid(pid, out_status, 0);
    } while (waited < 0 && errno == EINTR);
    if (waited != pid) {
        softsim_error_add(im->error, SOFTSIM_ERROR_SYSTEM, "%s: lost track of %s (%s)", im->path,
                          program, strerror(errno));
        return false;
    }
    return true;
}

/* ---- its answer ---- */

static softsim_status refuse(import *im, const char *what)
{
    softsim_error_add(im->error, SOFTSIM_ERROR_FORMAT,
                      "%s: %s: write the mesh again from the program that made it, or as OBJ",
                      im->path, what);
    return SOFTSIM_ERROR_FORMAT;
}

/* The first line of what it said, from the ':' behind its name and the file's. */
static const char *first_line(import *im)
{
    char place[MAX_TEXT];
    im->text[im->text_size] = '\0';
    im->text[strcspn(im->text, "\r\n")] = '\0';
    (void)snprintf(place, sizeof place, SS_IMPORT_NAME "%s%s", dash_guard(im->path), im->path);
    ss_plain_clean(place);
    const size_t length = strlen(place);
    if (strncmp(im->text, place, length) == 0) {
        return im->text + length;
    }
    return im->text[0] != '\0' ? im->text : "the importer gave no reason";
}

/* What ended it is said as what it is: a limit or a fault of its own proves nothing of the file. */
static softsim_status judge_end(import *im, int status)
{
    char what[128];
    if (im->stopped != NULL) {
        (void)snprintf(what, sizeof what, "the importer %s and was stopped", im->stopped);
        return refuse(im, what);
    }
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) {
        (void)snprintf(what, sizeof what, "the importer used up its %d s of CPU time",
                       (int)SS_IMPORT_MAX_CPU_S);
        return refuse(im, what);
    }
    if (WIFSIGNALED(status) && strstr(first_line(im), "bad_alloc") != NULL) {
        softsim_error_add(im->error, SOFTSIM_ERROR_FORMAT,
                          "%s: too large for the importer's memory: simplify the mesh first",
                          im->path);
        return SOFTSIM_ERROR_FORMAT;
    }
    if (WIFSIGNALED(status)) {
        (void)snprintf(what, sizeof what, "the importer itself ended by signal %d (%s)",
                       WTERMSIG(status), strsignal(WTERMSIG(status)));
        return refuse(im, what);
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        const char *line = first_line(im);
        softsim_error_add(im->error, SOFTSIM_ERROR_FORMAT, "%s%s%s", im->path,
                          line[0] == ':' ? "" : ": ", line);
        return SOFTSIM_ERROR_FORMAT;
    }
    return SOFTSIM_OK;
}

/* Checks sizes, indices and positions, scales, and makes the mesh. */
static softsim_status unpack(import *im, ss_mesh **out_mesh)
{
    ss_import_header header;
    if (im->out.size < sizeof header) {
        return refuse(im, "the importer's answer is cut off");
    }
    memcpy(&header, im->out.data, sizeof header);
    const size_t rest = im->out.size - sizeof header;
    const int64_t bound = (int64_t)rest;
    const bool has_quads = header.quad_count > 0;
    const int64_t face_count = has_quads ? header.quad_count : header.triangle_count;
    const size_t corners = has_quads ? 4 : 3;
    if (memcmp(header.magic, SS_IMPORT_MAGIC, sizeof header.magic) != 0 || header.node_count < 1 ||
        header.node_count > bound || face_count < 1 || face_count > bound ||
        (has_quads ? header.triangle_count != 0 : header.quad_count != 0) ||
        header.cut_face_count < 0 || header.cut_face_count > (has_quads ? 0 : bound) ||
        header.joined_count < 0 || header.joined_count > INT32_MAX || header.unused_count < 0 ||
        header.unused_count > INT32_MAX ||
        (size_t)header.node_count * 24 + (size_t)face_count * 4 * corners != rest) {
        return refuse(im, "the importer's answer makes no sense");
    }
    /* 56-byte header, so both arrays are aligned in the allocation. */
    double(*position)[3] = (double(*)[3])(void *)(im->out.data + sizeof header);
    const int32_t *node = (const int32_t *)(const void *)(position + header.node_count);
    int64_t bad_count = 0;
    int64_t first_bad = -1;
    for (int64_t i = 0; i < header.node_count; ++i) {
        ss_scale3(position[i], position[i], im->metres_per_unit);
        if (!ss_is_finite(position[i], 3)) {
            first_bad = bad_count++ == 0 ? i : first_bad;
        }
    }
    if (bad_count > 0) {
        softsim_error_add(im->error, SOFTSIM_ERROR_FORMAT,
                          "%s: %lld of its positions are not finite (the first is vertex %lld as "
                          "read): correct or remove them",
                          im->path, (long long)bad_count, (long long)first_bad);
        return SOFTSIM_ERROR_FORMAT;
    }
    for (size_t i = 0; i < (size_t)face_count * corners; ++i) {
        if (node[i] < 0 || node[i] >= header.node_count) {
            return refuse(im, "a face has a vertex that does not exist");
        }
    }
    const double(*x)[3] = (const double(*)[3])position;
    const softsim_status status =
        has_quads ? ss_mesh_create_quads((int32_t)header.node_count, x, (int32_t)face_count,
                                         (const int32_t(*)[4])node, out_mesh, im->error)
                  : ss_mesh_create((int32_t)header.node_count, x, (int32_t)face_count,
                                   (const int32_t(*)[3])node, 0, NULL, out_mesh, im->error);
    if (status == SOFTSIM_OK) {
        (*out_mesh)->cut_face_count = (int32_t)header.cut_face_count;
        (*out_mesh)->joined_node_count = (int32_t)header.joined_count;
        (*out_mesh)->unused_node_count = (int32_t)header.unused_count;
    }
    return status;
}

static softsim_status read_mesh(const ss_mesh_file *file, ss_mesh **out_mesh)
{
    char program[PATH_MAX] = "";
    const int reason = find_program(file->import_program, program);
    if (reason != 0 && program[0] == '\0') {
        softsim_error_add(file->error, SOFTSIM_ERROR_SYSTEM,
                          "%s: cannot look for softsim-import (%s)", file->path,
                          ss_files_reason(reason));
        return SOFTSIM_ERROR_SYSTEM;
    }
    if (reason != 0) {
        softsim_error_add(file->error, SOFTSIM_ERROR_SYSTEM,
                          "%s: the helper program softsim-import is not there (looked for %s): "
                          "install it, or give the mesh as MSH",
                          file->path, program);
        return SOFTSIM_ERROR_SYSTEM;
    }
import im = {.path = file->path, .metres_per_unit = file->metres_per_unit, .error = file->error };
    im.out.limit = SS_IMPORT_MAX_BYTES;
    int exit_status = 0;
    softsim_status status = SOFTSIM_ERROR_SYSTEM;
    if (run_program(&im, program, &exit_status)) {
        status = judge_end(&im, exit_status);
        if (status == SOFTSIM_OK) {
            status = unpack(&im, out_mesh);
        }
    }
    free(im.out.data);
    return status;
}

extern const ss_mesh_reader ss_mesh_reader_import;
const ss_mesh_reader ss_mesh_reader_import = {.name = "OBJ, STL, PLY, GLB or glTF (by the ending)",
                                              .extensions = ".obj .stl .ply .glb .gltf",
                                              .read = read_mesh};
