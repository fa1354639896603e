/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "rt/files.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

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
        for (int32_t k = 0; k < input_count && out->path != NULL; ++k) {
            if (input[k].path != NULL && ss_files_are_one(out->path, input[k].path)) {
                softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                                  "%s: '%s' is %s, which would be overwritten; give another name",
                                  out->name, out->path, input[k].name);
                return false;
            }
        }
        for (int32_t k = 0; k < i && out->path != NULL; ++k) {
            if (output[k].path != NULL && ss_files_are_one(out->path, output[k].path)) {
                softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                                  "%s: '%s' is also what %s writes; give each a file of its own",
                                  out->name, out->path, output[k].name);
                return false;
            }
        }
    }
    return true;
}
