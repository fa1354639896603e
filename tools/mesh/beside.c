/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "beside.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/files.h"

const char beside_no_memory[] = "out of memory";

/* ---- one open file ---- */

static FILE *stream_of(const struct aiFile *file)
{
    return (FILE *)(void *)file->UserData;
}

static size_t read_bytes(struct aiFile *file, char *out, size_t size, size_t count)
{
    return fread(out, size, count, stream_of(file));
}

static size_t write_nothing(struct aiFile *file, const char *data, size_t size, size_t count)
{
    (void)file, (void)data, (void)size, (void)count;
    return 0;
}

static size_t tell(struct aiFile *file)
{
    const long at = ftell(stream_of(file));
    return at > 0 ? (size_t)at : 0;
}

static size_t measure(struct aiFile *file)
{
    FILE *stream = stream_of(file);
    const long at = ftell(stream);
    const long size = fseek(stream, 0, SEEK_END) == 0 ? ftell(stream) : 0;
    return fseek(stream, at, SEEK_SET) == 0 && size > 0 ? (size_t)size : 0;
}

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    const int from = origin == aiOrigin_SET   ? SEEK_SET
                     : origin == aiOrigin_CUR ? SEEK_CUR
                                              : SEEK_END;
    return fseek(stream_of(file), (long)offset, from) == 0 ? aiReturn_SUCCESS : aiReturn_FAILURE;
}

static void flush_nothing(struct aiFile *file)
{
    (void)file;
}

/* ---- permission to open ---- */

static FILE *refuse(beside_files *files, const char *path, const char *why)
{
    if (files->refused[0] == '\0') {
        (void)snprintf(files->refused, sizeof files->refused, "it names '%.180s': %s", path, why);
    }
    return NULL;
}

/* Does the path, links and all, stay in the mesh's folder? What is not there does. */
static bool is_beside(const beside_files *files, const char *path)
{
    char found[PATH_MAX];
    const size_t length = strlen(files->folder);
    if (realpath(path, found) == NULL) {
        return true;
    }
    return length > 0 && strncmp(found, files->folder, length) == 0 &&
           (found[length] == '/' || length == 1);
}

static FILE *open_stream(beside_files *files, const char *path)
{
    const char *why = NULL;
    if (files->text != NULL) {
        return strcmp(path, files->path) == 0 ? fmemopen(files->text, files->size, "rb") : NULL;
    }
    if (strcmp(path, files->path) != 0 && !is_beside(files, path)) {
        return refuse(files, path, "not beside it; put what it needs into its own folder");
    }
    FILE *stream = ss_files_open_stream(path, NULL, &why);
    return stream != NULL ? stream : refuse(files, path, why);
}

static struct aiFile *open_file(struct aiFileIO *io, const char *path, const char *mode)
{
    struct aiFile *file = mode[0] == 'r' ? calloc(1, sizeof *file) : NULL;
    FILE *stream = file != NULL ? open_stream((beside_files *)(void *)io->UserData, path) : NULL;
    if (stream == NULL) {
        free(file);
        return NULL;
    }
    *file = (struct aiFile){.ReadProc = read_bytes,
                            .WriteProc = write_nothing,
                            .TellProc = tell,
                            .FileSizeProc = measure,
                            .SeekProc = seek,
                            .FlushProc = flush_nothing,
                            .UserData = (aiUserData)(void *)stream};
    return file;
}

static void close_file(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    (void)fclose(stream_of(file));
    free(file);
}

void beside_init(beside_files *files, const char *path, char *text, size_t size)
{
    const char *slash = strrchr(path, '/');
    char folder[PATH_MAX];
    *files = (beside_files){.io = {open_file, close_file, (aiUserData)(void *)files},
                            .path = path,
                            .text = text,
                            .size = size};
    const int length =
        snprintf(folder, sizeof folder, "%.*s.", slash != NULL ? (int)(slash - path) + 1 : 0, path);
    if (length >= (int)sizeof folder || realpath(folder, files->folder) == NULL) {
        files->folder[0] = '\0';
    }
}
