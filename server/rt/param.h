/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * One row per settable value. The scene's keys, the models' parameters and the programs' options
 * are all described by such rows; reading, range errors, --help, --print-config, --set and the
 * command `set` read nothing else.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* What a number may be: up to `max`, from `min` or above it. */
typedef struct ss_range {
    double min, max;
    bool exclusive_min;
} ss_range;

/* In a row: what its numbers may be. */
#define SS_FROM(least, most)  .range.min = (least), .range.max = (most)
#define SS_ABOVE(bound, most) SS_FROM(bound, most), .range.exclusive_min = true

/* A NaN is in no range. */
static inline bool ss_in_range(const ss_range *range, double value)
{
    return value <= range->max && (range->exclusive_min ? value > range->min : value >= range->min);
}

typedef enum ss_param_kind {
    SS_PARAM_NUMBER,  /* one double */
    SS_PARAM_INTEGER, /* one integer, kept as a double */
    SS_PARAM_BOOL,    /* 0 or 1 */
    SS_PARAM_CHOICE,  /* index into `choices` */
    SS_PARAM_FIELD,   /* a number, or a value per node by region list or file; per link too, where
                         the row takes_links, by a file with the header node,node,value */
    /* [x, y, z] of any length but 0, or one per element by file: normalised. Elements are the
     * tetrahedra of a volume mesh, else the quads, else the triangles (ss_mesh_element_count). min,
     * max and fallback mean nothing, and it cannot be live. */
    SS_PARAM_DIRECTION
} ss_param_kind;

typedef struct ss_param_row {
    const char *name; /* with its unit, as the user writes it */
    ss_param_kind kind;
    ss_range range;
    bool is_required;
    bool is_live;        /* the command `set` reaches it */
    bool takes_elements; /* a FIELD whose file may give a value per element instead */
    bool takes_links;    /* a FIELD whose file may give a value per link instead */
    double fallback;     /* the default; NaN: absent unless given */
    const char *choices; /* "a|b|c" for SS_PARAM_CHOICE */
    const char *help;
} ss_param_row;

/* A row from its kind, name and help; the other fields, where they are not 0, stand behind. */
#define SS_PARAM(of_kind, key, ...)                                                                \
    {                                                                                              \
        .name = (key), .kind = SS_PARAM_##of_kind, .help = __VA_ARGS__                             \
    }
/* The fallback of a row that is absent unless given. */
#define SS_ABSENT ((double)NAN)

/* A value for the link between two nodes. */
typedef struct ss_param_link {
    int32_t node[2];
    double value;
} ss_param_link;

/* Values for a table of rows, in row order. */
typedef struct ss_param_value {
    double number;           /* of NUMBER, INTEGER, BOOL, CHOICE, and of a uniform FIELD */
    double *per_node;        /* of a FIELD that varies: node_count values; NULL when uniform */
    double *by_element;      /* of a FIELD by a file of elements; then per_node is NULL */
    ss_param_link *per_link; /* of a FIELD by link: link_count values; else NULL */
    int32_t link_count;
    double direction[3];      /* of a uniform DIRECTION, a unit vector; 0 when not given */
    double (*per_element)[3]; /* of a DIRECTION by file, unit vectors; NULL when uniform */
    bool is_given;
} ss_param_value;
