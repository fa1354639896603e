/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A folder of a test's own and the files in it: shared by all tests that write some. The folder is
 * made before the first case, or before each, and goes with all that is in it. cmocka comes first.
 */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[] = "/tmp/softsim_test_XXXXXX";

/* The path of `name` in it; stays as it is for every name. */
static inline const char *in_folder(const char *name)
{
    static char *path[256];
    const size_t size = sizeof folder + strlen(name) + 1;
    for (size_t k = 0; k < sizeof path / sizeof *path; ++k) {
        if (path[k] == NULL || strcmp(path[k] + sizeof folder, name) == 0) {
            path[k] = path[k] != NULL ? path[k] : malloc(size);
            assert_non_null(path[k]);
            (void)snprintf(path[k], size, "%s/%s", folder, name);
            return path[k];
        }
    }
    fail_msg("too many names for in_folder: %s", name);
    return NULL;
}

static inline FILE *open_file(const char *name)
{
    FILE *file = fopen(in_folder(name), "wb");
    assert_non_null(file);
    return file;
}

/* Each gives the file's path. */
static inline const char *write_bytes(const char *name, const void *data, size_t size)
{
    FILE *file = open_file(name);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    return in_folder(name);
}

static inline const char *write_text(const char *name, const char *text)
{
    return write_bytes(name, text, strlen(text));
}

/* As much as there is room for, ended by a 0. */
static inline void read_text(const char *name, char *out, size_t size)
{
    FILE *file = fopen(in_folder(name), "rb");
    assert_non_null(file);
    out[fread(out, 1, size - 1, file)] = '\0';
    assert_int_equal(fclose(file), 0);
}

/* What is written to `stream` from now on goes to the file `path`; until it is restored. */
static inline int divert(FILE *stream, const char *path)
{
    fflush(stream);
    const int kept = dup(fileno(stream));
    const int file = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    assert_true(kept >= 0 && dup2(file, fileno(stream)) >= 0);
    close(file);
    return kept;
}

static inline void restore(FILE *stream, int kept)
{
    fflush(stream);
    dup2(kept, fileno(stream));
    close(kept);
}

static inline int make_folder(void **state)
{
    memset(folder + sizeof folder - 1 - 6, 'X', 6); /* it may be made again */
    return mkdtemp(folder) != NULL ? 0 : -1;
}

static inline int remove_folder(void **state)
{
    char command[64];
    (void)snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}

/* In its place where a test may leave the files `name` only; fails where there is another. */
static inline int remove_only(const char *const *name, size_t count)
{
    for (size_t k = 0; k < count; ++k) {
        unlink(in_folder(name[k]));
    }
    return rmdir(folder);
}
