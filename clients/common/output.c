/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void forget(ss_output *output)
{
    free(output->path);
    free(output->temporary);
    *output = (ss_output){0};
}

static void remove_temporary(const ss_output *output)
{
    if (output->temporary != NULL) {
        unlink(output->temporary);
    }
}

/* A device or a pipe, which must be written to, not replaced. */
static bool is_special(const char *path)
{
    struct stat found;
    return stat(path, &found) == 0 && !S_ISREG(found.st_mode);
}

/* The open file that a name stands for; -1: none. Such a file may be a regular one, which a shell
 * has opened: another in its place would be one that nobody reads, and the name itself would go. */
static int descriptor_of(const char *path)
{
    int number = -1, used = 0;
    if (strcmp(path, "/dev/stdout") == 0 || strcmp(path, "/dev/stderr") == 0) {
        return strcmp(path, "/dev/stdout") == 0 ? STDOUT_FILENO : STDERR_FILENO;
    }
    return (sscanf(path, "/dev/fd/%4d%n", &number, &used) == 1 ||
            sscanf(path, "/proc/self/fd/%4d%n", &number, &used) == 1) &&
                   path[used] == '\0'
               ? number
               : -1;
}

/* On the same place in the file, so that what the program prints follows. */
static FILE *open_descriptor(int descriptor)
{
    const int own = fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
    FILE *file = own >= 0 ? fdopen(own, "wb") : NULL;
    if (file == NULL && own >= 0) {
        close(own);
    }
    return file;
}

softsim_status ss_output_open(ss_output *output, const char *path, softsim_error *error)
{
    *output = (ss_output){.path = strdup(path)};
    const int descriptor = descriptor_of(path);
    const bool is_in_place = descriptor >= 0 || is_special(path);
    if (output->path == NULL ||
        (!is_in_place && asprintf(&output->temporary, "%s.%ld.tmp", path, (long)getpid()) < 0)) {
        output->temporary = NULL;
        forget(output);
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
        return SOFTSIM_ERROR_MEMORY;
    }
    output->file = descriptor >= 0
                       ? open_descriptor(descriptor)
                       : fopen(output->temporary != NULL ? output->temporary : path, "wbe");
    if (output->file == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: %s", path, strerror(errno));
        forget(output);
        return SOFTSIM_ERROR_FILE;
    }
    return SOFTSIM_OK;
}

softsim_status ss_output_commit(ss_output *output, softsim_error *error)
{
    if (output->file == NULL) {
        return SOFTSIM_OK;
    }
    errno = 0;
    bool is_good = ferror(output->file) == 0 && fflush(output->file) == 0;
    if (is_good && fsync(fileno(output->file)) != 0) {
        is_good = errno == EINVAL || errno == EROFS; /* what cannot be synced: pipes, /dev/null */
    }
    is_good = fclose(output->file) == 0 && is_good;
    if (is_good && output->temporary != NULL) {
        is_good = rename(output->temporary, output->path) == 0;
    }
    if (!is_good) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: cannot write: %s", output->path,
                          errno != 0 ? strerror(errno) : "an earlier write failed");
        remove_temporary(output);
    }
    forget(output);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_FILE;
}

void ss_output_abandon(ss_output *output)
{
    if (output->file != NULL) {
        fclose(output->file);
        remove_temporary(output);
        forget(output);
    }
}
