/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What was written, kept with the scene so that it can be printed again, and how values are
 * written. Used inside scene/ only.
 */
#include <stdio.h>

#include "scene/schema.h"

struct ss_scene_source {
    ss_scene_tree tree;
    ss_scene_row *model_row; /* the model's table as rows, `name` first */
    int32_t model_row_count;
    char folder[1024]; /* of the scene, "" or ending in / */
};

/* The file's bytes, to be freed; NULL with a fault in `error`. */
char *ss_scene_read_file(const char *path, size_t *out_size, softsim_error *error);

/* The shortest digits that read back as the same number; whole numbers in full, and an exponent
 * only behind a point and with its sign, as readers of YAML 1.1 need it too. */
void ss_scene_put_number(FILE *stream, double value);
/* Words that YAML cannot misread stay plain, the rest goes into double quotes. */
void ss_scene_put_text(FILE *stream, const char *text, bool is_quoted);
