/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Every key of a scene, one row each; checking, binding, printing and the command `set` read
 * nothing else. A row of kind KEYS or ENTRIES has a table of its own below it, so that a key's path
 * is its way down the tables. Used inside scene/ only. Thread: set-up only.
 */
#include "scene/scene.h"
#include "scene/tree.h"

typedef enum ss_scene_kind {
    SS_SCENE_NUMBER,
    SS_SCENE_INTEGER,
    SS_SCENE_BOOL,
    SS_SCENE_CHOICE,
    SS_SCENE_RATE, /* a number, or the word auto (kept as 0) */
    SS_SCENE_TEXT,
    SS_SCENE_FILE,      /* a path relative to the scene */
    SS_SCENE_VECTOR,    /* [x, y, z] */
    SS_SCENE_BOX,       /* [[x, y, z], [x, y, z]], the lower corner first */
    SS_SCENE_AXES,      /* a subset of xyz */
    SS_SCENE_NODES,     /* [0, 1, 2], or a file with one number a line */
    SS_SCENE_FIELD,     /* a number, {file: ...} or a list of regions */
    SS_SCENE_DIRECTION, /* [x, y, z] of a length, or {file: ...} */
    SS_SCENE_KEYS,      /* a mapping, keys from `child` */
    SS_SCENE_MODEL,     /* a mapping, keys from the chosen model */
    SS_SCENE_ENTRIES    /* a list of mappings, keys from `child` */
} ss_scene_kind;

typedef struct ss_scene_row ss_scene_row;

typedef struct ss_scene_table {
    const ss_scene_row *row;
    int32_t count;
} ss_scene_table;

struct ss_scene_row {
    const char *name;
    ss_scene_kind kind;
    const char *unit; /* for messages; NULL none */
    ss_range range;   /* of each number */
    bool is_required;
    bool takes_elements;  /* FIELD: a file may have the header element,value */
    char one_of;          /* keys of a table with the same letter: A..Z exactly one of them must be
                             given, a..z at most one; 0: independent */
    const char *needs;    /* a key of the same mapping without which this one means nothing */
    const char *unless;   /* a key of the same mapping beside which this one is not required */
    double fallback;      /* of numbers, choices (index) and each component of a vector */
    const char *choices;  /* "a|b|c" */
    const char *help;     /* NULL: the key is described by its table */
    const char *example;  /* as --print-config shows it beside the key, line by line; NULL: none */
    ss_scene_table child; /* KEYS, ENTRIES */
    int32_t field;        /* 1 + byte offset in ss_scene of the value, 0 none: a double (VECTOR: 3),
                             of INTEGER and CHOICE an int32_t */
    bool takes_links;     /* a field by file may be one by link */
    int32_t live;         /* 1 + ss_scene_live_key, 0: not while running */
};

extern const ss_scene_table ss_scene_root;       /* of the file */
extern const ss_scene_table ss_scene_where;      /* of a region list's `where` */
extern const ss_scene_table ss_scene_values;     /* of a field given by file */
extern const ss_scene_table ss_scene_directions; /* of a direction given by file */

/* Metres of choice k of a `units` key. */
extern const double ss_scene_unit_metres[];

/* What checking a tree needs and leaves behind. */
typedef struct ss_scene_check {
    ss_scene_report *report;
    const ss_scene_model *models;
    int32_t model_count;
    ss_scene *scene;         /* rows with a field are bound here */
    ss_scene_row *model_row; /* out: the chosen model's table as rows, `name` first; to be freed */
    int32_t model_row_count; /* out: 0 when no model was found */
} ss_scene_check;

/* Puts every default into `scene`. */
void ss_scene_set_defaults(ss_scene *scene);
/* Checks the tree against the tables, reports every fault and binds what has a field. Memory
 * failure is a fault too. */
void ss_scene_check_tree(ss_scene_check *check, ss_scene_node *root);

const ss_scene_row *ss_scene_find_row(ss_scene_table table, const char *name);
/* Name i of a list of rows, of models: for the two below. */
const char *ss_scene_row_name(const void *list, int32_t i);
const char *ss_scene_model_name(const void *list, int32_t i);
/* "a, b, c" */
void ss_scene_join(const char *(*name_at)(const void *list, int32_t i), const void *list,
                   int32_t count, char *out, size_t size);
/* The name nearest to `name` among `count`, or NULL when none is near. */
const char *ss_scene_nearest(const char *name, const char *(*name_at)(const void *list, int32_t i),
                             const void *list, int32_t count);
/* Index of `text` in "a|b|c", or -1. */
int32_t ss_scene_choice(const char *choices, const char *text);
/* Copies choice `index` of "a|b|c". */
void ss_scene_choice_name(const char *choices, int32_t index, char *out, size_t size);
/* "a number above 0 and at most 100 (N)": what a row takes. */
void ss_scene_describe(const ss_scene_row *row, char *out, size_t size);
/* A scalar of a row from its text; false with the reason (static or in `why`) when it is not one.
 */
bool ss_scene_read_scalar(const ss_scene_row *row, const char *text, bool is_quoted,
                          double *out_value, char *why, size_t why_size);
/* What is given for a model's row below the scene's `model`; a row `a.b` is key b of mapping a. */
ss_scene_node *ss_scene_find_model_node(const ss_scene_node *model, const char *name);
/* `row` of a model as a row of a scene. */
ss_scene_row ss_scene_row_of_param(const ss_param_row *param);

/* Values of checked nodes: `fallback` when the key is absent. */
double ss_scene_get_number(const ss_scene_node *map, const char *key, double fallback);
bool ss_scene_get_vector(const ss_scene_node *list, double out[3]);
/* Makes v a unit vector; false when it has no length. Its numbers are finite. */
bool ss_scene_normalise(double v[3]);
