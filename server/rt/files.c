/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/files.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

const char *ss_files_reason(int number)
{
    switch (number) {
    case EMFILE:
    case ENFILE:
        return "too many open files: raise `ulimit -n`";
    case ENOSPC:
    case EDQUOT:
        return "the disk is full: make room, or name a file on another";
    default:
        return strerror(number);
    }
}

enum { MAX_ROOM = 32 };

bool ss_files_have_room(int32_t count)
{
    int taken[MAX_ROOM];
    int32_t found = 0;
    while (found < count && found < MAX_ROOM && (taken[found] = dup(STDERR_FILENO)) >= 0) {
        ++found;
    }
    const bool has_room = found == count || found == MAX_ROOM;
    while (found > 0) {
        close(taken[--found]);
    }
    return has_room;
}

static const char *name_kind(mode_t mode)
{
    return S_ISDIR(mode)    ? "a folder, not a file"
           : S_ISFIFO(mode) ? "a pipe, not a file"
           : S_ISSOCK(mode) ? "a socket, not a file"
                            : "a device, not a file";
}

int ss_files_open(const char *path, int64_t *out_size, const char **out_why)
{
    struct stat found;
    /* What it is comes first, because opening a device may do something, and opening a pipe lets
     * its writer go on. It may be another file by the time it is opened: hence without waiting,
     * and a second look. */
    if (stat(path, &found) == 0 && !S_ISREG(found.st_mode)) {
        *out_why = name_kind(found.st_mode);
        return -1;
    }
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (file < 0 || fstat(file, &found) != 0) {
        *out_why = ss_files_reason(errno);
    } else if (!S_ISREG(found.st_mode)) {
        *out_why = name_kind(found.st_mode);
    } else {
        if (out_size != NULL) {
            *out_size = (int64_t)found.st_size;
        }
        return file;
    }
    if (file >= 0) {
        close(file);
    }
    return -1;
}

FILE *ss_files_open_stream(const char *path, int64_t *out_size, const char **out_why)
{
    const int file = ss_files_open(path, out_size, out_why);
    FILE *stream = file >= 0 ? fdopen(file, "rb") : NULL;
    if (stream == NULL && file >= 0) {
        *out_why = ss_files_reason(errno);
        close(file);
    }
    return stream;
}

/* ---- outputs ---- */

int ss_files_descriptor(const char *path)
{
    static const char *const folder[] = {"/dev/fd/", "/proc/self/fd/"};
    if (strcmp(path, "/dev/stdout") == 0 || strcmp(path, "/dev/stderr") == 0) {
        return strcmp(path, "/dev/stdout") == 0 ? STDOUT_FILENO : STDERR_FILENO;
    }
    for (size_t k = 0; k < sizeof folder / sizeof *folder; ++k) {
        const size_t length = strlen(folder[k]);
        const char *number = path + length;
        if (strncmp(path, folder[k], length) == 0) {
            const size_t digits = strspn(number, "0123456789");
            return digits >= 1 && digits <= 4 && number[digits] == '\0' ? atoi(number) : -1;
        }
    }
    return -1;
}

/* /dev/null and /dev/full: written to without waiting, and nothing comes of it. */
static bool is_sink(const struct stat *found)
{
    return S_ISCHR(found->st_mode) &&
           (found->st_rdev == makedev(1, 3) || found->st_rdev == makedev(1, 7));
}

bool ss_files_is_in_place(const char *path)
{
    struct stat found;
    return ss_files_descriptor(path) >= 0 || (stat(path, &found) == 0 && is_sink(&found));
}

const char *ss_files_why_no_output(const char *path)
{
    struct stat found;
    return ss_files_is_in_place(path) || stat(path, &found) != 0 || S_ISREG(found.st_mode)
               ? NULL
               : name_kind(found.st_mode);
}

/* ---- streams that remember why ---- */

typedef struct sink {
    int descriptor;
    int *reason;
} sink;

static ssize_t write_sink(void *cookie, const char *data, size_t size)
{
    const sink *to = cookie;
    size_t done = 0;
    while (done < size && *to->reason == 0) {
        const ssize_t count = write(to->descriptor, data + done, size - done);
        if (count == 0 || (count < 0 && errno != EINTR)) {
            *to->reason = count == 0 ? EIO : errno;
        }
        done += count > 0 ? (size_t)count : 0;
    }
    return (ssize_t)done;
}

static int close_sink(void *cookie)
{
    const sink *to = cookie;
    const int result = close(to->descriptor);
    free(cookie);
    return result;
}

FILE *ss_files_write_stream(int descriptor, int *out_reason)
{
    sink *to = malloc(sizeof *to);
    const cookie_io_functions_t does = {.write = write_sink, .close = close_sink};
    FILE *stream = to != NULL ? fopencookie(to, "wb", does) : NULL;
    if (stream == NULL) {
        free(to);
        errno = ENOMEM;
        return NULL;
    }
    *out_reason = 0;
    *to = (sink){descriptor, out_reason};
    return stream;
}

/* A file that is there, or the folder of one that is not yet and its name in it. */
typedef struct identity {
    bool is_known;
    dev_t device;
    ino_t inode;
    const char *name; /* "" of a file that is there */
} identity;

static identity identify(const char *path)
{
    struct stat found;
    char folder[PATH_MAX];
    if (stat(path, &found) == 0) {
        return (identity){S_ISREG(found.st_mode), found.st_dev, found.st_ino, ""};
    }
    const char *slash = strrchr(path, '/');
    const int length = slash != NULL ? (int)(slash - path) + 1 : 0;
    const int wanted = snprintf(folder, sizeof folder, "%.*s.", length, path);
    if (wanted >= (int)sizeof folder || stat(folder, &found) != 0) {
        return (identity){.is_known = false};
    }
    return (identity){true, found.st_dev, found.st_ino, path + length};
}

bool ss_files_are_one(const char *a, const char *b)
{
    const identity x = identify(a), y = identify(b);
    return x.is_known && y.is_known && x.device == y.device && x.inode == y.inode &&
           strcmp(x.name, y.name) == 0;
}

bool ss_files_check(const ss_named_file *input, int32_t input_count, const ss_named_file *output,
                    int32_t output_count, softsim_error *error)
{
    for (int32_t i = 0; i < output_count; ++i) {
        const ss_named_file *out = &output[i];
        if (out->path != NULL && out->path[0] == '\0') {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s: the name is empty; give one",
                              out->name);
            return false;
        }
        const char *why = out->path != NULL ? ss_files_why_no_output(out->path) : NULL;
        struct stat found;
        if (why != NULL && (stat(out->path, &found) != 0 || !S_ISDIR(found.st_mode))) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s: '%s' is %s; give another name",
                              out->name, out->path, why);
            return false;
        }
        char part[PATH_MAX] = "";
        (void)snprintf(part, sizeof part, "%s" SS_FILES_PART, out->path != NULL ? out->path : "");
        for (int32_t k = 0; k < input_count && out->path != NULL; ++k) {
            if (input[k].path != NULL && ss_files_are_one(part, input[k].path)) {
                softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                                  "%s: '%s' is recorded to '%s', which is %s; give another name",
                                  out->name, out->path, part, input[k].name);
                return false;
            }
            if (input[k].path != NULL && ss_files_are_one(out->path, input[k].path)) {
                softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                                  "%s: '%s' is %s, which would be overwritten; give another name",
                                  out->name, out->path, input[k].name);
                return false;
            }
        }
        for (int32_t k = 0; k < i && out->path != NULL; ++k) {
            char other[PATH_MAX] = "";
            (void)snprintf(other, sizeof other, "%s" SS_FILES_PART,
                           output[k].path != NULL ? output[k].path : "");
            if (output[k].path != NULL &&
                (ss_files_are_one(out->path, output[k].path) ||
                 ss_files_are_one(part, output[k].path) || ss_files_are_one(out->path, other))) {
                softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                                  "%s: '%s' is also what %s writes; give each a file of its own",
                                  out->name, out->path, output[k].name);
                return false;
            }
        }
    }
    return true;
}
