/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Loading mesh files. What MSH and VTK start with tells them, whatever their names; TetGen's pair
 * of files, which are but numbers, and the formats that the helper program knows (import.c) are
 * told by their names' endings.
 */
#include "mesh/mesh.h"
#include "mesh/readers.h"
#include "rt/files.h"
#include "rt/progress.h"
#include "rt/vec.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum { MAX_FILE_BYTES = 1 << 30, START_BYTES = 4096 /* within which <VTKFile must come */ };

typedef softsim_status parser(ss_text *text, double metres_per_unit, ss_mesh **out_mesh);

/* ---- files ---- */

static softsim_status fail_file(const char *path, const char *why, softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_FILE,
                      "%s: cannot read it (%s): check its name and rights", path, why);
    return SOFTSIM_ERROR_FILE;
}

/* An open regular file of a size that can be read, or -1 with the fault in `error`. */
static int open_file(const char *path, size_t *out_size, softsim_status *out_status,
                     softsim_error *error)
{
    int64_t size = 0;
    const char *why = NULL;
    const int fd = ss_files_open(path, &size, &why);
    *out_status = SOFTSIM_ERROR_FILE;
    if (fd < 0) {
        (void)fail_file(path, why, error);
        return -1;
    }
    if (size > 0 && size <= MAX_FILE_BYTES) {
        *out_size = (size_t)size;
        *out_status = SOFTSIM_OK;
        return fd;
    }
    *out_status = SOFTSIM_ERROR_FORMAT;
    softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s: %s", path,
                      size == 0 ? "the file is empty: write it again"
                                : "larger than 1 GiB: simplify the mesh first");
    (void)close(fd);
    return -1;
}

/* What the file starts with, behind blanks and a byte order mark; ends with a zero. */
static const char *read_start(int fd, char buffer[START_BYTES])
{
    static const char mark[] = "\xEF\xBB\xBF";
    const ssize_t count = pread(fd, buffer, START_BYTES - 1, 0);
    buffer[count > 0 ? count : 0] = '\0';
    const char *start = buffer;
    start += strncmp(start, mark, sizeof mark - 1) == 0 ? sizeof mark - 1 : 0;
    return start + strspn(start, " \t\r\n");
}

static parser *find_parser(const char *start)
{
    static const char vtk[] = "# vtk DataFile";
    return *start == '$'                                     ? ss_mesh_parse_msh
           : strncasecmp(start, vtk, sizeof vtk - 1) == 0    ? ss_mesh_parse_vtk
           : *start == '<' && strstr(start, "<VTKFile") != 0 ? ss_mesh_parse_vtu
                                                             : NULL;
}

static const char *extension_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *extension = strrchr(slash != NULL ? slash : path, '.');
    return extension != NULL ? extension : "";
}

static bool is_importable(const char *extension)
{
    static const char *const known[] = {".obj", ".stl", ".ply", ".glb", ".gltf"};
    bool is_known = false;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        is_known = is_known || strcasecmp(extension, known[i]) == 0;
    }
    return is_known;
}

/* ---- readers ---- */

/* `start`: where what the reader is to see begins. */
static softsim_status parse_file(int fd, size_t size, int64_t start, const char *path,
                                 parser *parse, double metres_per_unit, ss_mesh **out_mesh,
                                 softsim_error *error)
{
    ss_text text;
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (ss_text_open(&text, fd, (int64_t)size, SS_TEXT_WINDOW, path, error)) {
        ss_text_seek(&text, (ss_text_mark){.offset = start});
        status = parse(&text, metres_per_unit, out_mesh);
    }
    ss_text_fini(&text);
    return status;
}

bool ss_mesh_name_pair(const char *path, char *out, size_t size)
{
    const char *extension = extension_of(path);
    const bool is_node = strcasecmp(extension, ".node") == 0;
    const bool is_upper = extension[0] == '.' && (extension[1] == 'N' || extension[1] == 'E');
    if (!is_node && strcasecmp(extension, ".ele") != 0) {
        return false;
    }
    const int length =
        snprintf(out, size, "%.*s%s", (int)(extension - path), path,
                 is_node ? (is_upper ? ".ELE" : ".ele") : (is_upper ? ".NODE" : ".node"));
    return length > 0 && (size_t)length < size;
}

/* Reads the pair of which `path`, open as `fd`, is one. */
static softsim_status parse_pair(int fd, size_t size, const char *path, double metres_per_unit,
                                 ss_mesh **out_mesh, softsim_error *error)
{
    const bool is_node = strcasecmp(extension_of(path), ".node") == 0;
    char other_path[PATH_MAX];
    if (!ss_mesh_name_pair(path, other_path, sizeof other_path)) {
        return fail_file(path, "its name is too long", error);
    }
    size_t other_size = 0;
    softsim_status status = SOFTSIM_OK;
    const int other = open_file(other_path, &other_size, &status, error);
    if (other < 0) {
        return status;
    }
    ss_text mine;
    ss_text others = {0};
    status = SOFTSIM_ERROR_MEMORY;
    if (ss_text_open(&mine, fd, (int64_t)size, SS_TEXT_WINDOW, path, error) &&
        ss_text_open(&others, other, (int64_t)other_size, SS_TEXT_WINDOW, other_path, error)) {
        status = ss_mesh_parse_tetgen(is_node ? &mine : &others, is_node ? &others : &mine,
                                      metres_per_unit, out_mesh);
    }
    ss_text_fini(&mine);
    ss_text_fini(&others);
    (void)close(other);
    return status;
}

static softsim_status load_file(int fd, size_t size, const char *path, double metres_per_unit,
                                const char *import_program, ss_mesh **out_mesh,
                                softsim_error *error)
{
    char buffer[START_BYTES];
    const char *start = read_start(fd, buffer);
    const char *extension = extension_of(path);
    parser *parse = find_parser(start);
    if (parse != NULL) {
        /* Blanks stay, for the lines to be counted. */
        const int64_t mark = buffer[0] == '\xEF' ? 3 : 0;
        return parse_file(fd, size, mark, path, parse, metres_per_unit, out_mesh, error);
    }
    if (strcasecmp(extension, ".node") == 0 || strcasecmp(extension, ".ele") == 0) {
        return parse_pair(fd, size, path, metres_per_unit, out_mesh, error);
    }
    if (is_importable(extension)) {
        return ss_mesh_import(path, metres_per_unit, import_program, out_mesh, error);
    }
    softsim_error_add(error, SOFTSIM_ERROR_FORMAT,
                      "%s: not a mesh that is read here: give OBJ, STL, PLY, GLB, glTF or TetGen's "
                      ".node and .ele (by the file's ending), Gmsh MSH (ASCII) or VTK (legacy, or "
                      ".vtu in ASCII)",
                      path);
    return SOFTSIM_ERROR_FORMAT;
}

softsim_status ss_mesh_load(const char *path, double metres_per_unit, const char *import_program,
                            ss_mesh **out_mesh, softsim_error *error)
{
    *out_mesh = NULL;
    if (!(metres_per_unit > 0.0 && isfinite(metres_per_unit))) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: a unit of %g m: give a positive number", path, metres_per_unit);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    size_t size = 0;
    softsim_status status = SOFTSIM_OK;
    const int fd = open_file(path, &size, &status, error);
    if (fd < 0) {
        return status;
    }
    ss_progress_part("reading %s, %.0f MB", path, 1e-6 * (double)size);
    status = load_file(fd, size, path, metres_per_unit, import_program, out_mesh, error);
    (void)close(fd);
    return status;
}
