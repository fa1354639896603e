/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Loading mesh files by the table of readers (reader_rows.h, made by CMakeLists.txt). What a file
 * starts with tells its format, whatever its name; formats that are but numbers, or that the helper
 * program knows, are told by their names' endings.
 */
#include "mesh/mesh.h"
#include "mesh/readers.h"
#include "rt/files.h"
#include "rt/progress.h"
#include "rt/vec.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum { MAX_FILE_BYTES = 1 << 30, START_BYTES = 4096, MAX_NAMES = 512 };

#define SS_MESH_READER_ROW(object) extern const ss_mesh_reader object;
#include "reader_rows.h"
#undef SS_MESH_READER_ROW

static const ss_mesh_reader *const table[] = {
#define SS_MESH_READER_ROW(object) &object,
#include "reader_rows.h"
#undef SS_MESH_READER_ROW
};
enum { READER_COUNT = sizeof table / sizeof *table };

/* ---- files ---- */

int ss_mesh_open_file(const char *path, int64_t *out_size, softsim_status *out_status,
                      softsim_error *error)
{
    const char *why = NULL;
    const int fd = ss_files_open(path, out_size, &why);
    *out_status = SOFTSIM_ERROR_FILE;
    if (fd < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE,
                          "%s: cannot read it (%s): check its name and rights", path, why);
        return -1;
    }
    if (*out_size > 0 && *out_size <= MAX_FILE_BYTES) {
        *out_status = SOFTSIM_OK;
        return fd;
    }
    *out_status = SOFTSIM_ERROR_FORMAT;
    softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s: %s", path,
                      *out_size == 0 ? "the file is empty: write it again"
                                     : "larger than 1 GiB: simplify the mesh first");
    (void)close(fd);
    return -1;
}

const char *ss_mesh_extension(const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *extension = strrchr(slash != NULL ? slash : path, '.');
    return extension != NULL ? extension : "";
}

softsim_status ss_mesh_read_text(const ss_mesh_file *file, ss_mesh_parser *parse,
                                 ss_mesh **out_mesh)
{
    ss_text text;
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (ss_text_open(&text, file->fd, file->size, SS_TEXT_WINDOW, file->path, file->error)) {
        ss_text_seek(&text, (ss_text_mark){.offset = file->text_at});
        status = parse(&text, file->metres_per_unit, out_mesh);
    }
    ss_text_fini(&text);
    return status;
}

/* ---- readers ---- */

static bool has_extension(const ss_mesh_reader *reader, const char *extension)
{
    const size_t length = strlen(extension);
    const char *at = reader->extensions;
    while (at != NULL && *at != '\0') {
        const size_t word = strcspn(at, " ");
        if (word == length && strncasecmp(at, extension, length) == 0) {
            return true;
        }
        at += word;
        at += strspn(at, " ");
    }
    return false;
}

/* By content, then by name; NULL when no reader takes it. */
static const ss_mesh_reader *find_reader(const char *start, const char *extension)
{
    for (int i = 0; i < READER_COUNT; ++i) {
        if (table[i]->sniff != NULL && table[i]->sniff(start)) {
            return table[i];
        }
    }
    for (int i = 0; i < READER_COUNT; ++i) {
        if (has_extension(table[i], extension)) {
            return table[i];
        }
    }
    return NULL;
}

static softsim_status refuse(const ss_mesh_file *file)
{
    char names[MAX_NAMES] = "";
    size_t length = 0;
    for (int i = 0; i < READER_COUNT; ++i) {
        const int count = snprintf(names + length, sizeof names - length, "%s%s",
                                   i == 0                  ? ""
                                   : i == READER_COUNT - 1 ? " or "
                                                           : ", ",
                                   table[i]->name);
        length += count > 0 && (size_t)count < sizeof names - length ? (size_t)count : 0;
    }
    softsim_error_add(file->error, SOFTSIM_ERROR_FORMAT,
                      "%s: not a mesh that is read here: give %s", file->path, names);
    return SOFTSIM_ERROR_FORMAT;
}

static softsim_status load_file(ss_mesh_file *file, ss_mesh **out_mesh)
{
    static const char mark[] = "\xEF\xBB\xBF"; /* of the byte order */
    char start[START_BYTES];
    const ssize_t count = pread(file->fd, start, sizeof start - 1, 0);
    start[count > 0 ? count : 0] = '\0';
    /* Blanks stay, for the lines to be counted. */
    file->text_at = strncmp(start, mark, sizeof mark - 1) == 0 ? (int64_t)sizeof mark - 1 : 0;
    const char *first = start + file->text_at;
    const ss_mesh_reader *reader =
        find_reader(first + strspn(first, " \t\r\n"), ss_mesh_extension(file->path));
    return reader != NULL ? reader->read(file, out_mesh) : refuse(file);
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
    ss_mesh_file file = {.path = path,
                         .metres_per_unit = metres_per_unit,
                         .import_program = import_program,
                         .error = error};
    softsim_status status = SOFTSIM_OK;
    file.fd = ss_mesh_open_file(path, &file.size, &status, error);
    if (file.fd < 0) {
        return status;
    }
    ss_progress_part("reading %s, %.0f MB", path, 1e-6 * (double)file.size);
    status = load_file(&file, out_mesh);
    (void)close(file.fd);
    return status;
}
