/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What sections of all versions of MSH have: kinds of elements, physical groups, counts and ends.
 */
#include "mesh/draft.h"

typedef struct ss_msh_name {
    int32_t dimension, number;
    char name[sizeof((ss_mesh_group *)0)->name];
} ss_msh_name;

/* A point, curve, surface or volume of version 4, and which part of `group` it has. */
typedef struct ss_msh_entity {
    int32_t dimension, group_count;
    int64_t tag;
    int64_t first_group;
} ss_msh_entity;

typedef struct ss_msh {
    ss_text *text;
    ss_draft *draft;
    int version; /* 0 until known, 1, 2, 4 */
    bool has_elements;
    char other[128]; /* the first element that is not read, in words */
    ss_msh_name *name;
    int32_t name_count;
    ss_msh_entity *entity; /* sorted by dimension and tag */
    int64_t entity_count;
    int32_t *group; /* of the draft */
    int64_t group_count;
} ss_msh;

/* The kind of an element of Gmsh's type number, and its name. */
ss_mesh_kind ss_msh_kind(int64_t type);
const char *ss_msh_type_name(int64_t type);
/* The node of a number that element `index` has; -1 is a fault. */
int32_t ss_msh_find_node(const ss_msh *r, int64_t index, int64_t number);
/* Room for the elements that were counted; on from `start`, before them. */
bool ss_msh_begin_elements(ss_msh *r, ss_text_mark start);
/* Keeps the first type that makes no mesh, for the error when nothing else is there. */
void ss_msh_note_other(ss_msh *r, int64_t index, int64_t type);
/* The draft's group of a physical number, made when it is not there yet; -1 is a fault. */
int32_t ss_msh_find_group(ss_msh *r, int32_t dimension, int64_t number);
/* Dimension of the elements of a kind, 0 to 3. */
int32_t ss_msh_dimension(ss_mesh_kind kind);
/* Is the next line `end`? A fault when not. */
bool ss_msh_expect_end(ss_msh *r, const char *end);
/* May `count` records of at least `least` bytes follow? A fault when not. */
bool ss_msh_has_room(ss_msh *r, int64_t count, int64_t least, const char *what);
