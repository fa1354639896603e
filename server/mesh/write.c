/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Writers. A file appears whole or not at all: it is written beside its place under a name of its
 * own, synced and renamed. What is no file (/dev/stdout) is refused, lest it be replaced by one.
 * Positions are written so that reading them gives the same doubles, groups so that our readers
 * give the same groups.
 */
#include "mesh/mesh.h"
#include "mesh/second_order.h"
#include "rt/files.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <errno.h>
#include <fcntl.h>
#include <float.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct output {
    FILE *file;
    int descriptor, reason; /* of `file`; errno of the write that failed */
    const char *path;
    char temporary[PATH_MAX];
    softsim_error *error;
} output;

static softsim_status fail_output(output *out)
{
    softsim_error_add(out->error, SOFTSIM_ERROR_FILE,
                      "%s: cannot write it (%s): check the folder, its rights and the disk",
                      out->path, ss_files_reason(out->reason != 0 ? out->reason : errno));
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
    out->descriptor = open(out->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (out->descriptor < 0) {
        out->temporary[0] = '\0';
        return fail_output(out);
    }
    out->file = ss_files_write_stream(out->descriptor, &out->reason);
    if (out->file == NULL) {
        out->reason = errno;
        (void)close(out->descriptor);
        return fail_output(out);
    }
    return SOFTSIM_OK;
}

static softsim_status close_output(output *out)
{
    if (ferror(out->file) != 0 || fflush(out->file) != 0 || fsync(out->descriptor) != 0) {
        return fail_output(out);
    }
    FILE *file = out->file;
    out->file = NULL;
    if (fclose(file) != 0 || rename(out->temporary, out->path) != 0) {
        return fail_output(out);
    }
    return SOFTSIM_OK;
}

/* x y z in as few digits, of 15 to 17, as give the same doubles again. */
static void put_position(FILE *file, const double *x)
{
    for (int k = 0; k < 3; ++k) {
        char text[32];
        for (int digits = 15; digits <= 17; ++digits) {
            (void)snprintf(text, sizeof text, "%.*g", digits, x[k]);
            if (strtod(text, NULL) == x[k]) {
                break;
            }
        }
        (void)fprintf(file, "%s%c", text, k < 2 ? ' ' : '\n');
    }
}

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
                number[i] = ++count;
                (void)fputs("v ", out.file);
                put_position(out.file, mesh->position[i]);
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

/* Little-endian, whatever the machine. */
static void put_word(FILE *file, uint32_t word)
{
    for (int k = 0; k < 4; ++k) {
        (void)fputc((int)(word >> (8 * k) & 255u), file);
    }
}

static void put_single(FILE *file, double value)
{
    const float single = (float)value;
    uint32_t word;
    memcpy(&word, &single, sizeof word);
    put_word(file, word);
}

/* The first node that single precision cannot say; -1: none. */
static int32_t find_beyond_single(const ss_mesh *mesh)
{
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (!(fabs(mesh->position[i][k]) <= (double)FLT_MAX)) {
                return i;
            }
        }
    }
    return -1;
}

/* 80 bytes, the count, and of each triangle its normal, corners and two bytes. */
softsim_status ss_mesh_write_stl(const ss_mesh *mesh, const char *path, softsim_error *error)
{
    const int32_t beyond = find_beyond_single(mesh);
    if (beyond >= 0) {
        softsim_error_add(
            error, SOFTSIM_ERROR_MESH,
            "%s: node %d is beyond what STL can say (%.2g): scale it, or give another "
            "format",
            path, beyond, (double)FLT_MAX);
        return SOFTSIM_ERROR_MESH;
    }
    output out;
    softsim_status status = open_output(&out, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    (void)fprintf(out.file, "%-80s", "binary STL");
    put_word(out.file, (uint32_t)mesh->triangle_count);
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *node = mesh->triangle[t];
        double normal[3];
        ss_normal3(normal, mesh->position[node[0]], mesh->position[node[1]],
                   mesh->position[node[2]]);
        (void)ss_normalize3(normal);
        for (int k = 0; k < 12; ++k) {
            put_single(out.file, k < 3 ? normal[k] : mesh->position[node[k / 3 - 1]][k % 3]);
        }
        (void)fputc(0, out.file);
        (void)fputc(0, out.file);
    }
    return close_output(&out);
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

/* The i-th node of tetrahedron e, with middles in a format's order. */
static int32_t node_of(const ss_mesh *mesh, int32_t e, int i, const int8_t *sides)
{
    return i < 4 ? mesh->tetrahedron[e][i] : mesh->middle[e][sides[i - 4]];
}

static void write_msh_tetrahedra(FILE *file, const ss_mesh *mesh, int64_t *inout_element)
{
    const bool is_second = mesh->middle != NULL;
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        (void)fprintf(file, "%lld %d 2 0 1", (long long)(*inout_element)++, is_second ? 11 : 4);
        for (int i = 0; i < (is_second ? 10 : 4); ++i) {
            (void)fprintf(file, " %d", node_of(mesh, e, i, ss_mesh_edges_of_gmsh) + 1);
        }
        (void)fputc('\n', file);
    }
}

/* Faces of second order, each of four quarters. */
static void write_msh_faces(FILE *file, const ss_mesh *mesh, int64_t *inout_element)
{
    for (int32_t t = 0; t < mesh->triangle_count; t += 4) {
        const int32_t(*four)[3] = (const int32_t(*)[3])mesh->triangle + t;
        (void)fprintf(file, "%lld 9 2 0 1 %d %d %d %d %d %d\n", (long long)(*inout_element)++,
                      four[0][0] + 1, four[1][0] + 1, four[2][0] + 1, four[3][0] + 1,
                      four[3][1] + 1, four[3][2] + 1);
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
        (void)fprintf(out.file, "%d ", i + 1);
        put_position(out.file, mesh->position[i]);
    }
    const bool is_second = mesh->middle != NULL;
    const int32_t triangle_count = mesh->quad_count > 0 || is_second ? 0 : mesh->triangle_count;
    int64_t count = (int64_t)mesh->quad_count + triangle_count + mesh->tetrahedron_count +
                    (is_second ? mesh->triangle_count / 4 : 0);
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
    if (is_second) {
        write_msh_faces(out.file, mesh, &element);
    }
    write_msh_tetrahedra(out.file, mesh, &element);
    (void)fprintf(out.file, "$EndElements\n");
    return close_output(&out);
}

/* What VTK's names of arrays cannot hold is written %20 and the like. */
static void put_name(FILE *file, const char *name)
{
    for (const unsigned char *c = (const unsigned char *)name; *c != '\0'; ++c) {
        if (*c > ' ' && *c < 0x7f && *c != '%' && *c != '"') {
            (void)fputc(*c, file);
        } else {
            (void)fprintf(file, "%%%02X", *c);
        }
    }
}

/* An array of zeros and ones for each group; the reader makes groups of such names again. */
static bool write_masks(FILE *file, const ss_mesh *mesh)
{
    uint8_t *mask = ss_memory_get((size_t)mesh->node_count, sizeof *mask);
    if (mask == NULL) {
        return false;
    }
    (void)fprintf(file, "POINT_DATA %d\nFIELD groups %d\n", mesh->node_count, mesh->group_count);
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        const ss_mesh_group *group = &mesh->group[g];
        for (int32_t i = 0; i < group->node_count; ++i) {
            mask[group->node[i]] = 1;
        }
        (void)fputs("group:", file);
        put_name(file, group->name);
        (void)fprintf(file, " 1 %d int\n", mesh->node_count);
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            (void)fprintf(file, "%d%c", mask[i],
                          i % 40 == 39 || i == mesh->node_count - 1 ? '\n' : ' ');
            mask[i] = 0;
        }
    }
    ss_memory_free(mask);
    return true;
}

static void write_cells(FILE *file, const char *section, const int32_t *node, int32_t count,
                        int corners)
{
    (void)fprintf(file, "%s %d %lld\n", section, count, (long long)count * (corners + 1));
    for (int32_t e = 0; e < count; ++e) {
        (void)fprintf(file, "%d", corners);
        for (int k = 0; k < corners; ++k) {
            (void)fprintf(file, " %d", node[(int64_t)corners * e + k]);
        }
        (void)fputc('\n', file);
    }
}

static void write_vtk_tetrahedra(FILE *file, const ss_mesh *mesh)
{
    const int nodes = mesh->middle != NULL ? 10 : 4;
    (void)fprintf(file, "CELLS %d %lld\n", mesh->tetrahedron_count,
                  (long long)mesh->tetrahedron_count * (nodes + 1));
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        (void)fprintf(file, "%d", nodes);
        for (int i = 0; i < nodes; ++i) {
            (void)fprintf(file, " %d", node_of(mesh, e, i, ss_mesh_edges_of_vtk));
        }
        (void)fputc('\n', file);
    }
    (void)fprintf(file, "CELL_TYPES %d\n", mesh->tetrahedron_count);
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        (void)fputs(mesh->middle != NULL ? "24\n" : "10\n", file);
    }
}

softsim_status ss_mesh_write_vtk(const ss_mesh *mesh, const char *path, softsim_error *error)
{
    const bool is_volume = mesh->tetrahedron_count > 0;
    output out;
    softsim_status status = open_output(&out, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    (void)fprintf(out.file,
                  "# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET %s\n"
                  "POINTS %d double\n",
                  is_volume ? "UNSTRUCTURED_GRID" : "POLYDATA", mesh->node_count);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        put_position(out.file, mesh->position[i]);
    }
    if (is_volume) {
        write_vtk_tetrahedra(out.file, mesh);
    } else if (mesh->quad_count > 0) {
        write_cells(out.file, "POLYGONS", (const int32_t *)mesh->quad, mesh->quad_count, 4);
    } else {
        write_cells(out.file, "POLYGONS", (const int32_t *)mesh->triangle, mesh->triangle_count, 3);
    }
    if (mesh->group_count > 0 && !write_masks(out.file, mesh)) {
        errno = ENOMEM;
        return fail_output(&out);
    }
    return close_output(&out);
}

softsim_status ss_mesh_write_cells(const ss_mesh *mesh, const ss_mesh_cell *cell, int32_t count,
                                   const char *name, const char *path, softsim_error *error)
{
    output out;
    const softsim_status status = open_output(&out, path, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    int64_t numbers = 0;
    for (int32_t i = 0; i < count; ++i) {
        numbers += cell[i].corners + 1;
    }
    (void)fprintf(out.file,
                  "# vtk DataFile Version 3.0\nelements\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                  "POINTS %d double\n",
                  mesh->node_count);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        put_position(out.file, mesh->position[i]);
    }
    (void)fprintf(out.file, "CELLS %d %lld\n", count, (long long)numbers);
    for (int32_t i = 0; i < count; ++i) {
        (void)fprintf(out.file, "%d", cell[i].corners);
        for (int k = 0; k < cell[i].corners; ++k) {
            (void)fprintf(out.file, " %d", cell[i].node[k]);
        }
        (void)fputc('\n', out.file);
    }
    (void)fprintf(out.file, "CELL_TYPES %d\n", count);
    for (int32_t i = 0; i < count; ++i) {
        (void)fprintf(out.file, "%d\n", cell[i].corners == 4 ? 10 : 5);
    }
    (void)fprintf(out.file, "CELL_DATA %d\nSCALARS %s int 1\nLOOKUP_TABLE default\n", count, name);
    for (int32_t i = 0; i < count; ++i) {
        (void)fprintf(out.file, "%d\n", cell[i].value);
    }
    return close_output(&out);
}
