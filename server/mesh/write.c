/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Writers. A file appears whole or not at all: it is written beside its place under a name of its
 * own, synced and renamed. What is no file (/dev/stdout) is refused, lest it be replaced by one.
 */
#include "mesh/mesh.h"
#include "rt/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct output {
    FILE *file;
    const char *path;
    char temporary[PATH_MAX];
    softsim_error *error;
} output;

static softsim_status fail_output(output *out)
{
    softsim_error_add(out->error, SOFTSIM_ERROR_FILE,
                      "%s: cannot write it (%s): check the folder, its rights and the disk",
                      out->path, strerror(errno));
    if (out->file != NULL) {
        (void)fclose(out->file);
    }
    if (out->temporary[0] != '\0') {
        (void)unlink(out->temporary);
    }
    return SOFTSIM_ERROR_FILE;
}

static softsim_status open_output(output *out, const char *path, softsim_error *error)
{
    *out = (output){.path = path, .error = error};
    struct stat found;
    if (stat(path, &found) == 0 && !S_ISREG(found.st_mode)) {
        errno = S_ISDIR(found.st_mode) ? EISDIR : ENOTSUP;
        return fail_output(out);
    }
    const int length =
        snprintf(out->temporary, sizeof out->temporary, "%s.%ld.tmp", path, (long)getpid());
    if (length < 0 || (size_t)length >= sizeof out->temporary) {
        out->temporary[0] = '\0';
        errno = ENAMETOOLONG;
        return fail_output(out);
    }
    const int fd = open(out->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0) {
        out->temporary[0] = '\0';
        return fail_output(out);
    }
    out->file = fdopen(fd, "w");
    if (out->file == NULL) {
        const int reason = errno;
        (void)close(fd);
        errno = reason;
        return fail_output(out);
    }
    return SOFTSIM_OK;
}

static softsim_status close_output(output *out)
{
    if (ferror(out->file) != 0 || fflush(out->file) != 0 || fsync(fileno(out->file)) != 0) {
        return fail_output(out);
    }
    FILE *file = out->file;
    out->file = NULL;
    if (fclose(file) != 0 || rename(out->temporary, out->path) != 0) {
        return fail_output(out);
    }
    return SOFTSIM_OK;
}

/* Nine digits: what reads OBJ files mostly keeps floats. */
softsim_status ss_mesh_write_obj(const ss_mesh *mesh, const char *path, softsim_error *error)
{
    /* The interior of a volume is no part of its surface: numbers close up over it. */
    const bool keeps_all = mesh->tetrahedron_count == 0;
    int32_t *number = ss_memory_get((size_t)mesh->node_count, sizeof *number);
    if (number == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            number[mesh->triangle[t][k]] = 1;
        }
    }
    output out;
    softsim_status status = open_output(&out, path, error);
    if (status == SOFTSIM_OK) {
        int32_t count = 0;
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            if (keeps_all || number[i] != 0) {
                const double *x = mesh->position[i];
                number[i] = ++count;
                (void)fprintf(out.file, "v %.9g %.9g %.9g\n", x[0], x[1], x[2]);
            }
        }
        for (int32_t q = 0; q < mesh->quad_count; ++q) {
            const int32_t *node = mesh->quad[q];
            (void)fprintf(out.file, "f %d %d %d %d\n", number[node[0]], number[node[1]],
                          number[node[2]], number[node[3]]);
        }
        for (int32_t t = 0; t < mesh->triangle_count && mesh->quad_count == 0; ++t) {
            const int32_t *node = mesh->triangle[t];
            (void)fprintf(out.file, "f %d %d %d\n", number[node[0]], number[node[1]],
                          number[node[2]]);
        }
        status = close_output(&out);
    }
    ss_memory_free(number);
    return status;
}

/* Elements carry one physical group each, but a node may be in any number of groups: groups are
 * written as points, of dimension 0. */
static void write_groups(FILE *file, const ss_mesh *mesh, int64_t *inout_element)
{
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        for (int32_t i = 0; i < mesh->group[g].node_count; ++i) {
            (void)fprintf(file, "%lld 15 2 %d 0 %d\n", (long long)(*inout_element)++, g + 1,
                          mesh->group[g].node[i] + 1);
        }
    }
}

softsim_status ss_mesh_write_msh(const ss_mesh *mesh, const char *path, softsim_error *error)
{
    output out;
    softsim_status status = open_output(&out, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    (void)fprintf(out.file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    if (mesh->group_count > 0) {
        (void)fprintf(out.file, "$PhysicalNames\n%d\n", mesh->group_count);
        for (int32_t g = 0; g < mesh->group_count; ++g) {
            (void)fprintf(out.file, "0 %d \"%s\"\n", g + 1, mesh->group[g].name);
        }
        (void)fprintf(out.file, "$EndPhysicalNames\n");
    }
    (void)fprintf(out.file, "$Nodes\n%d\n", mesh->node_count);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        const double *x = mesh->position[i];
        (void)fprintf(out.file, "%d %.17g %.17g %.17g\n", i + 1, x[0], x[1], x[2]);
    }
    const int32_t triangle_count = mesh->quad_count > 0 ? 0 : mesh->triangle_count;
    int64_t count = (int64_t)mesh->quad_count + triangle_count + mesh->tetrahedron_count;
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        count += mesh->group[g].node_count;
    }
    (void)fprintf(out.file, "$EndNodes\n$Elements\n%lld\n", (long long)count);
    int64_t element = 1;
    write_groups(out.file, mesh, &element);
    for (int32_t q = 0; q < mesh->quad_count; ++q) {
        const int32_t *node = mesh->quad[q];
        (void)fprintf(out.file, "%lld 3 2 0 1 %d %d %d %d\n", (long long)element++, node[0] + 1,
                      node[1] + 1, node[2] + 1, node[3] + 1);
    }
    for (int32_t t = 0; t < triangle_count; ++t) {
        const int32_t *node = mesh->triangle[t];
        (void)fprintf(out.file, "%lld 2 2 0 1 %d %d %d\n", (long long)element++, node[0] + 1,
                      node[1] + 1, node[2] + 1);
    }
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        const int32_t *node = mesh->tetrahedron[e];
        (void)fprintf(out.file, "%lld 4 2 0 1 %d %d %d %d\n", (long long)element++, node[0] + 1,
                      node[1] + 1, node[2] + 1, node[3] + 1);
    }
    (void)fprintf(out.file, "$EndElements\n");
    return close_output(&out);
}
