/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The files that assimp may open: the mesh itself and, of glTF, the buffers that it names, which
 * are regular files in the mesh's folder or below it. A name that leads out of it, by `..`, from
 * the root or over a symbolic link, and a pipe or device are refused: a mesh from elsewhere must
 * not read a file of the user's, nor wait for one. OBJ and PLY files are handed over as prepared
 * (obj.h, ply.h) and may open nothing: materials are left out.
 * Thread: one; the process ends soon, and nothing is freed but what assimp closes.
 */
#include <limits.h>
#include <stddef.h>

#include <assimp/cfileio.h>

typedef struct beside_files {
    struct aiFileIO io; /* for assimp; its UserData is this */
    const char *path;   /* the mesh */
    char *text;         /* the mesh as prepared, or NULL */
    size_t size;
    char folder[PATH_MAX]; /* resolved; "" when it is not known */
    char refused[300];     /* why the first file was not opened; "": none was refused */
} beside_files;

/* What those who prepare a mesh say then. */
extern const char beside_no_memory[];

/* `text`, of `size` bytes: the mesh as prepared; NULL: assimp reads the file. */
void beside_init(beside_files *files, const char *path, char *text, size_t size);
