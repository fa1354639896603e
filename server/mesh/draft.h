/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Inside server/mesh only: a mesh as a reader of volumes and surfaces makes it, whatever the
 * format. A reader counts the elements of each kind (found), asks for room, adds nodes and
 * elements in the file's order, and names nodes for groups; finishing hands the arrays over to the
 * mesh without a copy. Nothing that a file says is trusted here either: an element beyond the room
 * that the first pass over the file found for it is refused.
 */
#include "mesh/mesh.h"
#include "mesh/text.h"

enum {
    SS_DRAFT_MAX_COUNT = 64 * 1024 * 1024, /* nodes, or elements: ids times six fit an int32 */
    SS_DRAFT_MAX_GROUPS = 1024,
    SS_DRAFT_MAX_VALUES = 64,       /* an array of more distinct values names no groups */
    SS_DRAFT_MAX_MEMBERS = 1 << 28, /* nodes of all groups together, with room to grow: 1 GiB */
    SS_DRAFT_MAX_NODES = 10         /* of an element that is kept, or names nodes */
};

/* Numbers of nodes as a file gives them, and what they stand for. */
typedef struct ss_draft_tag {
    int64_t tag;
    int32_t index;
    int32_t line;
} ss_draft_tag;

typedef struct ss_draft_group {
    int64_t key; /* groups come out in the order of their keys */
    char name[sizeof((ss_mesh_group *)0)->name];
    int32_t *node; /* some of them more than once, until they are gathered */
    int32_t count, capacity;
} ss_draft_group;

typedef struct ss_draft {
    ss_text *text;
    double metres_per_unit;
    int32_t node_count;
    double (*position)[3];
    ss_draft_tag *tag; /* sorted by tag once ss_draft_sort_tags has been called */
    int64_t found[SS_MESH_KIND_COUNT];
    int32_t triangle_room, quad_room, tetrahedron_room;
    int32_t triangle_count, quad_count, tetrahedron_count, cut_count;
    int32_t (*triangle)[3], (*quad)[4], (*tetrahedron)[4];
    int32_t (*middle)[6];                      /* NULL in a mesh of first order */
    ss_draft_group group[SS_DRAFT_MAX_GROUPS]; /* in the order in which they were asked for */
    int32_t order[SS_DRAFT_MAX_GROUPS];        /* of their keys */
    int32_t group_count;
    int64_t member_room; /* of all groups */
    uint64_t *bits;      /* a node each, zero between uses */
} ss_draft;

/* Values of the nodes or elements, of which each distinct one names a group. */
typedef struct ss_draft_field {
    int64_t value[SS_DRAFT_MAX_VALUES];
    int32_t group[SS_DRAFT_MAX_VALUES]; /* -1: none */
    int32_t value_count;
    bool names_none; /* too many values, or too long a name */
    uint8_t last;    /* code of the value before */
    uint8_t *code;   /* count */
} ss_draft_field;

ss_draft *ss_draft_create(ss_text *text, double metres_per_unit);
void ss_draft_destroy(ss_draft **draft);

/* All of these that return bool: false once reading has to stop, with the fault in the text. */

/* Room for `count` nodes, and for their tags. */
bool ss_draft_make_nodes(ss_draft *d, int64_t count, bool has_tags);
/* Puts node i at x (in the file's unit). */
bool ss_draft_put_node(ss_draft *d, int32_t i, const double x[3]);
/* After the last: refuses a tag that is there twice. */
bool ss_draft_sort_tags(ss_draft *d);
/* Index of the node with `tag`, -1 when there is none. */
int32_t ss_draft_find_node(const ss_draft *d, int64_t tag);

/* Nodes of an element that is kept, or names nodes for groups; 0 for other kinds. */
int ss_draft_nodes(ss_mesh_kind kind);
/* Tetrahedra, or a cell that is split into them. */
bool ss_draft_is_volume(ss_mesh_kind kind);
/* Does a file of nothing but this kind, or points and lines, make a mesh? */
bool ss_draft_makes_mesh(ss_mesh_kind kind);
/* Room for what was found; a fault when nothing was that makes a mesh. `other` says what else was
 * (NULL: the kinds tell). */
bool ss_draft_make_elements(ss_draft *d, const char *other);
/* `edges`: of a tetrahedron of second order, its edges in the order of the format; NULL where it
 * has none. */
bool ss_draft_add_element(ss_draft *d, ss_mesh_kind kind, const int32_t *node, const int8_t *edges);

/* The group of this key, made when it is not there yet (`name` NULL: named later); -1 is a fault.
 */
int32_t ss_draft_find_group(ss_draft *d, int64_t key, const char *name);
bool ss_draft_mark(ss_draft *d, int32_t group, int32_t node);

bool ss_draft_make_field(ss_draft *d, ss_draft_field *field, int64_t count);
void ss_draft_set_field(ss_draft_field *field, int64_t i, int64_t value);
/* Makes the groups NAME=VALUE (of at most 63 bytes), in increasing order of values and of `ordinal`
 * among arrays; for an array of zeros and ones called "group:NAME" the one group NAME. */
bool ss_draft_name_field(ss_draft *d, ss_draft_field *field, const char *name, int32_t ordinal);
/* The group of the i-th value, or -1. */
int32_t ss_draft_field_group(const ss_draft_field *field, int64_t i);
void ss_draft_field_fini(ss_draft_field *field);

/* Makes the mesh; the draft is then to be destroyed. */
softsim_status ss_draft_finish(ss_draft *d, ss_mesh **out_mesh);
