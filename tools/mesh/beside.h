/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The files that assimp may open: the mesh itself and, of glTF, the buffers that it names, which
 * are regular files in the mesh's folder or below it. A name that leads out of it, by `..`, from
 * the root or over a symbolic link, and a pipe or device are refused: a mesh from elsewhere must
 * not read a file of the user's, nor wait for one. An OBJ file is handed over as prepared (obj.h)
 * and may open nothing: its materials are left out.
 * Thread: one; the process ends soon, and nothing is freed but what assimp closes.
 */
#include <limits.h>
#include <stddef.h>

#include <assimp/cfileio.h>

#include "obj.h"

typedef struct beside_files {
    struct aiFileIO io; /* for assimp; its UserData is this */
    const char *path;   /* the mesh */
    const obj_text *obj;
    char folder[PATH_MAX]; /* resolved; "" when it is not known */
    char refused[300];     /* why the first file was not opened; "": none was refused */
} beside_files;

/* `obj`: the prepared text of the mesh, or NULL. */
void beside_init(beside_files *files, const char *path, const obj_text *obj);
