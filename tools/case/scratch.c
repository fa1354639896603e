/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "case/scratch.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PATH_SIZE = 1024 };
static const char ending[] = "XXXXXX";

static const char *parent_for(const char *name)
{
    const char *parent = getenv("TMPDIR");
    return parent != NULL && parent[0] == '/' &&
                   strlen(parent) + strlen(name) + sizeof "/-" + sizeof ending <= SS_SCRATCH_PATH
               ? parent
               : "/tmp";
}

softsim_status ss_scratch_make(const char *name, char out[SS_SCRATCH_PATH], softsim_error *error)
{
    const char *parent = parent_for(name);
    snprintf(out, SS_SCRATCH_PATH, "%s/%s-%s", parent, name, ending);
    if (mkdtemp(out) == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "cannot make a folder in %s: %s", parent,
                          strerror(errno));
        out[0] = '\0';
        return SOFTSIM_ERROR_FILE;
    }
    return SOFTSIM_OK;
}

static void clear(const char *path, int levels)
{
    const int fd = open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    DIR *folder = fd >= 0 ? fdopendir(fd) : NULL;
    if (folder == NULL) {
        if (fd >= 0) {
            close(fd);
        }
        return;
    }
    for (const struct dirent *at = readdir(folder); at != NULL; at = readdir(folder)) {
        char inner[PATH_SIZE];
        snprintf(inner, sizeof inner, "%s/%s", path, at->d_name);
        if (strcmp(at->d_name, ".") != 0 && strcmp(at->d_name, "..") != 0 && unlink(inner) != 0 &&
            levels > 0) {
            clear(inner, levels - 1);
        }
    }
    closedir(folder);
    rmdir(path);
}

void ss_scratch_remove(const char *folder)
{
    if (folder[0] != '\0' && unlink(folder) != 0) { /* a link to what is not ours goes alone */
        clear(folder, 1);
    }
}

void ss_scratch_remove_all(const char *name)
{
    const char *parent = parent_for(name);
    const size_t length = strlen(name);
    DIR *folder = opendir(parent);
    for (const struct dirent *at = folder != NULL ? readdir(folder) : NULL; at != NULL;
         at = readdir(folder)) {
        char path[PATH_SIZE];
        if (strncmp(at->d_name, name, length) == 0 && at->d_name[length] == '-' &&
            strlen(at->d_name) == length + sizeof ending) {
            snprintf(path, sizeof path, "%s/%s", parent, at->d_name);
            ss_scratch_remove(path);
        }
    }
    if (folder != NULL) {
        closedir(folder);
    }
}
