/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * YAML text to a tree of nodes that know where they stand in the text.
 *
 * In: the text of a scene (stranger's input) and `path.to.key=value` overrides. Out: one node per
 * scalar, list and mapping, with key, byte range and origin; memory belongs to the tree. Bounded:
 * size of the text, depth, number of nodes, keys per mapping. Anchors, aliases, tags and a second
 * document are refused: a scene needs none of them, and without aliases nothing can be small in
 * the file and huge in memory. Used inside scene/, and by tools that read YAML of their own.
 * Thread: set-up only.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "scene/report.h"
#include "softsim/types.h"

enum {
    SS_SCENE_MAX_BYTES = 16 << 20, /* longer lists of nodes belong in files of their own */
    SS_SCENE_MAX_DEPTH = 16,       /* the deepest key of a scene stands at 8 */
    SS_SCENE_MAX_NODES = 500000,   /* also of the marks [ { , ! & * ? that make them */
    SS_SCENE_MAX_KEYS = 256,       /* of one mapping; bounds the quadratic search for a key */
    SS_SCENE_MAX_ENTRIES = 1024    /* of a list of mappings: each may walk over the whole mesh */
};

typedef enum ss_scene_node_kind { SS_SCENE_SCALAR, SS_SCENE_LIST, SS_SCENE_MAP } ss_scene_node_kind;

typedef struct ss_scene_node {
    ss_scene_node_kind kind;
    bool is_quoted;      /* scalar in quotes: never a number */
    bool is_faulty;      /* a fault was reported at it or below it */
    bool is_path;        /* the schema says it names a file */
    int32_t index;       /* among its siblings, from 0 */
    int32_t count;       /* children */
    int32_t override;    /* -1: from the file */
    uint32_t key_offset; /* bytes from the start of the text */
    uint32_t key_length;
    uint32_t offset, length;
    const char *key;  /* in a mapping, else NULL */
    const char *text; /* of a scalar; never NULL there */
    struct ss_scene_node *parent, *first, *last, *next;
} ss_scene_node;

typedef struct ss_scene_block ss_scene_block;

typedef struct ss_scene_tree {
    ss_scene_node *root; /* NULL until parsed */
    int32_t node_count;
    ss_scene_block *block;
} ss_scene_tree;

/* Parses `size` bytes; faults go to the report. True when the tree is whole and its root is a
 * mapping. */
bool ss_scene_tree_parse(ss_scene_tree *tree, ss_scene_report *report, const char *text,
                         size_t size);
/* Puts override number `index` (PATH=VALUE) into the tree, creating mappings on the way: whether
 * such a key exists is for the schema to say. VALUE is taken literally, or as a YAML flow list or
 * mapping when it begins with [ or {. */
void ss_scene_tree_override(ss_scene_tree *tree, ss_scene_report *report, int32_t index);
void ss_scene_tree_fini(ss_scene_tree *tree);

ss_scene_node *ss_scene_node_find(const ss_scene_node *map, const char *key);
/* Goes down from `node` as the path says ("contact.tools.0.probe", up to `end`) and returns the
 * last node that there is; *out_rest is the part of the path that leads on from it, `end` when none
 * is left. NULL where the path is malformed. */
ss_scene_node *ss_scene_node_locate(ss_scene_node *node, const char *path, const char *end,
                                    const char **out_rest);
/* "contact.tools.0.shape": cut where it does not fit. */
void ss_scene_node_path(const ss_scene_node *node, char *out, size_t size);
/* Text that is one finite number from end to end, digits as in JSON or C (no hex, no inf). */
typedef enum ss_scene_number {
    SS_SCENE_GOOD,
    SS_SCENE_NOT_NUMBER,
    SS_SCENE_NOT_FINITE
} ss_scene_number;
ss_scene_number ss_scene_parse_number(const char *text, double *out_value);

/* Reports a fault at the node's value, or at its key, and marks it and all above it faulty. */
void ss_scene_node_fault(ss_scene_report *report, ss_scene_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void ss_scene_key_fault(ss_scene_report *report, ss_scene_node *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
ss_scene_place ss_scene_node_place(const ss_scene_node *node);
