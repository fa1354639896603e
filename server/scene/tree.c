/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The tree is built from libfyaml's events rather than from its documents: aliases, tags and
 * depth are refused as they come, before anything is composed; duplicate keys become faults with
 * a place like any other; an override can be put in beside what the file says.
 */
#include "scene/tree.h"

#include <errno.h>
#include <libfyaml.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/plain.h"

/* ---- memory ---- */

enum { BLOCK_SIZE = 1 << 16 };

struct ss_scene_block {
    ss_scene_block *next;
    size_t used, size;
    max_align_t data[];
};

/* Zeroed memory that lives as long as the tree; NULL when there is none. */
static void *take(ss_scene_tree *tree, size_t size)
{
    size = (size + sizeof(max_align_t) - 1) / sizeof(max_align_t) * sizeof(max_align_t);
    ss_scene_block *block = tree->block;
    if (block == NULL || block->size - block->used < size) {
        const size_t capacity = size > BLOCK_SIZE ? size : BLOCK_SIZE;
        block = calloc(1, sizeof *block + capacity);
        if (block == NULL) {
            return NULL;
        }
        block->size = capacity;
        block->next = tree->block;
        tree->block = block;
    }
    void *memory = (char *)block->data + block->used;
    block->used += size;
    return memory;
}

static const char *take_text(ss_scene_tree *tree, const char *text, size_t length)
{
    char *copy = take(tree, length + 1);
    if (copy != NULL) {
        memcpy(copy, text, length);
    }
    return copy;
}

static ss_scene_node *take_node(ss_scene_tree *tree, ss_scene_node_kind kind, int32_t override)
{
    ss_scene_node *node = take(tree, sizeof *node);
    if (node != NULL) {
        node->kind = kind;
        node->override = override;
        tree->node_count += 1;
    }
    return node;
}

static void append(ss_scene_node *parent, ss_scene_node *node)
{
    node->parent = parent;
    node->index = parent->count++;
    if (parent->last != NULL) {
        parent->last->next = node;
    } else {
        parent->first = node;
    }
    parent->last = node;
}

void ss_scene_tree_fini(ss_scene_tree *tree)
{
    while (tree->block != NULL) {
        ss_scene_block *next = tree->block->next;
        free(tree->block);
        tree->block = next;
    }
    *tree = (ss_scene_tree){0};
}

/* ---- reading a node ---- */

ss_scene_node *ss_scene_node_find(const ss_scene_node *map, const char *key)
{
    if (map == NULL || map->kind != SS_SCENE_MAP) {
        return NULL;
    }
    for (ss_scene_node *node = map->first; node != NULL; node = node->next) {
        if (strcmp(node->key, key) == 0) {
            return node;
        }
    }
    return NULL;
}

void ss_scene_node_path(const ss_scene_node *node, char *out, size_t size)
{
    const ss_scene_node *chain[SS_SCENE_MAX_DEPTH + 2];
    int count = 0;
    for (; node != NULL && node->parent != NULL && count < SS_SCENE_MAX_DEPTH + 2;
         node = node->parent) {
        chain[count++] = node;
    }
    size_t used = 0;
    out[0] = '\0';
    while (count > 0 && used < size) {
        node = chain[--count];
        const char *dot = used > 0 ? "." : "";
        const int length = node->key != NULL
                               ? snprintf(out + used, size - used, "%s%.64s", dot, node->key)
                               : snprintf(out + used, size - used, "%s%d", dot, (int)node->index);
        used += length > 0 ? (size_t)length : 0;
    }
}

ss_scene_number ss_scene_parse_number(const char *text, double *out_value)
{
    const size_t length = strnlen(text, 64);
    if (length == 0 || length == 64) {
        return SS_SCENE_NOT_NUMBER;
    }
    if (strspn(text, "0123456789+-.eE") != length) {
        static const char *const not_finite[] = {".inf", "inf", "infinity", ".nan", "nan"};
        const char *word = text + (text[0] == '+' || text[0] == '-');
        for (size_t i = 0; i < sizeof not_finite / sizeof *not_finite; i++) {
            if (strcasecmp(word, not_finite[i]) == 0) {
                return SS_SCENE_NOT_FINITE;
            }
        }
        return SS_SCENE_NOT_NUMBER;
    }
    char *end = NULL;
    const double value = strtod(text, &end);
    if (end != text + length) {
        return SS_SCENE_NOT_NUMBER;
    }
    if (!isfinite(value)) {
        return SS_SCENE_NOT_FINITE;
    }
    *out_value = value;
    return SS_SCENE_GOOD;
}

ss_scene_place ss_scene_node_place(const ss_scene_node *node)
{
    return (ss_scene_place){node->override, node->offset, node->length};
}

static void mark_faulty(ss_scene_node *node)
{
    for (; node != NULL; node = node->parent) {
        node->is_faulty = true;
    }
}

static void add_fault(ss_scene_report *report, ss_scene_node *node, ss_scene_place place,
                      const char *format, va_list arguments)
{
    char text[640];
    vsnprintf(text, sizeof text, format, arguments);
    mark_faulty(node);
    ss_scene_report_add(report, SOFTSIM_ERROR_SCENE, place, "%s", text);
}

void ss_scene_node_fault(ss_scene_report *report, ss_scene_node *node, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    add_fault(report, node, ss_scene_node_place(node), format, arguments);
    va_end(arguments);
}

void ss_scene_key_fault(ss_scene_report *report, ss_scene_node *node, const char *format, ...)
{
    const ss_scene_place key = {node->override, node->key_offset, node->key_length};
    va_list arguments;
    va_start(arguments, format);
    add_fault(report, node, node->key_length > 0 ? key : ss_scene_node_place(node), format,
              arguments);
    va_end(arguments);
}

/* ---- parsing ---- */

/* One parse: of the file, or of the value of an override. */
typedef struct builder {
    ss_scene_tree *tree;
    ss_scene_report *report;
    int32_t override;
    ss_scene_node *open[SS_SCENE_MAX_DEPTH];
    int depth;
    ss_scene_node *root;
    const char *key; /* read, its value still to come */
    ss_scene_place key_place;
    uint32_t position; /* end of the last token seen: where an empty value stands */
    int documents;
    bool is_bad;
} builder;

static void refuse(builder *b, ss_scene_place place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static void refuse(builder *b, ss_scene_place place, const char *format, ...)
{
    char text[320];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    b->is_bad = true;
    ss_scene_report_add(b->report, SOFTSIM_ERROR_FORMAT, place, "%s", text);
}

static ss_scene_place place_of(builder *b, struct fy_event *event)
{
    const struct fy_mark *start = fy_event_start_mark(event);
    const struct fy_mark *end = fy_event_end_mark(event);
    ss_scene_place place = {b->override, b->position, 0};
    if (start != NULL && end != NULL) {
        place.offset = (uint32_t)start->input_pos;
        place.length = (uint32_t)(end->input_pos - start->input_pos);
        b->position = (uint32_t)end->input_pos;
    }
    return place;
}

/* Hangs a new node under the open list or mapping; false when it must not be. */
static ss_scene_node *add_node(builder *b, ss_scene_node_kind kind, ss_scene_place place)
{
    ss_scene_node *parent = b->depth > 0 ? b->open[b->depth - 1] : NULL;
    if (b->tree->node_count >= SS_SCENE_MAX_NODES) {
        refuse(b, place, "more than %d values; put long lists of nodes into files of their own",
               SS_SCENE_MAX_NODES);
        return NULL;
    }
    if (parent != NULL && parent->kind == SS_SCENE_MAP && parent->count >= SS_SCENE_MAX_KEYS) {
        refuse(b, b->key_place, "more than %d keys in one mapping", SS_SCENE_MAX_KEYS);
        return NULL;
    }
    ss_scene_node *node = take_node(b->tree, kind, b->override);
    if (node == NULL) {
        refuse(b, place, "out of memory");
        return NULL;
    }
    node->offset = place.offset;
    node->length = place.length;
    if (parent == NULL) {
        b->root = node;
        return node;
    }
    if (parent->kind == SS_SCENE_MAP) {
        node->key = b->key;
        node->key_offset = b->key_place.offset;
        node->key_length = b->key_place.length;
        b->key = NULL;
    }
    append(parent, node);
    return node;
}

static bool expects_key(const builder *b)
{
    return b->depth > 0 && b->open[b->depth - 1]->kind == SS_SCENE_MAP && b->key == NULL;
}

static void take_scalar(builder *b, struct fy_event *event)
{
    const ss_scene_place place = place_of(b, event);
    size_t length = 0;
    const char *text = fy_token_get_text(event->scalar.value, &length);
    if (text == NULL) {
        text = "";
        length = 0;
    }
    if (memchr(text, '\0', length) != NULL) {
        refuse(b, place, "a NUL character in a text; remove it");
        return;
    }
    const char *copy = take_text(b->tree, text, length);
    if (copy == NULL) {
        refuse(b, place, "out of memory");
        return;
    }
    if (expects_key(b)) {
        b->key = copy;
        b->key_place = place;
        return;
    }
    ss_scene_node *node = add_node(b, SS_SCENE_SCALAR, place);
    if (node != NULL) {
        node->text = copy;
        node->is_quoted = fy_token_scalar_style(event->scalar.value) != FYSS_PLAIN;
    }
}

static void open_node(builder *b, struct fy_event *event, ss_scene_node_kind kind)
{
    const ss_scene_place place = place_of(b, event);
    if (expects_key(b)) {
        refuse(b, place, "a key must be a word, not a list or a mapping");
        return;
    }
    if (b->depth == SS_SCENE_MAX_DEPTH) {
        refuse(b, place, "nested deeper than %d levels", SS_SCENE_MAX_DEPTH);
        return;
    }
    ss_scene_node *node = add_node(b, kind, place);
    if (node != NULL) {
        b->open[b->depth++] = node;
    }
}

/* A block mapping begins at its first key, a flow one at its brace: keep both in sight. */
static void take_event(builder *b, struct fy_event *event)
{
    struct fy_token *anchor = NULL;
    struct fy_token *tag = NULL;
    switch (event->type) {
    case FYET_SCALAR:
        anchor = event->scalar.anchor;
        tag = event->scalar.tag;
        break;
    case FYET_MAPPING_START:
        anchor = event->mapping_start.anchor;
        tag = event->mapping_start.tag;
        break;
    case FYET_SEQUENCE_START:
        anchor = event->sequence_start.anchor;
        tag = event->sequence_start.tag;
        break;
    default:
        break;
    }
    if (anchor != NULL || tag != NULL || event->type == FYET_ALIAS) {
        refuse(b, place_of(b, event), "anchors, aliases and tags are not taken in a scene; %s",
               tag != NULL ? "remove the tag" : "write the value out");
        return;
    }
    switch (event->type) {
    case FYET_DOCUMENT_START:
        if (++b->documents > 1) {
            refuse(b, place_of(b, event), "a second document begins here; a scene is one document");
        }
        break;
    case FYET_SCALAR:
        take_scalar(b, event);
        break;
    case FYET_MAPPING_START:
        open_node(b, event, SS_SCENE_MAP);
        break;
    case FYET_SEQUENCE_START:
        open_node(b, event, SS_SCENE_LIST);
        break;
    case FYET_MAPPING_END:
    case FYET_SEQUENCE_END:
        place_of(b, event);
        b->depth -= b->depth > 0;
        break;
    default:
        break;
    }
}

/* Byte offset of a line and column, both from 1, columns counted in characters. */
static uint32_t offset_of(const char *text, size_t size, int line, int column)
{
    size_t i = 0;
    for (int at = 1; at < line && i < size; i++) {
        at += text[i] == '\n';
    }
    for (int at = 1; at < column && i < size && text[i] != '\n'; at++) {
        for (i++; i < size && ((unsigned char)text[i] & 0xc0) == 0x80; i++) {
        }
    }
    return (uint32_t)i;
}

static void refuse_syntax(builder *b, struct fy_diag *diag, const char *text, size_t size)
{
    void *cursor = NULL;
    const struct fy_diag_error *error = fy_diag_errors_iterate(diag, &cursor);
    if (error == NULL) {
        refuse(b, (ss_scene_place){b->override, b->position, 0}, "this is not YAML");
        return;
    }
    const ss_scene_place place = {b->override, offset_of(text, size, error->line, error->column),
                                  1};
    refuse(b, place, "%s; correct the YAML", error->msg);
}

/* What must not reach the parser: libfyaml 0.7.12 never returns from a directive with a byte that
 * is not UTF-8, and a scene needs no directive; and it gathers the tokens of a whole flow list,
 * 500 bytes each, before it hands out the first. */
static bool is_plain_text(builder *b, const char *text, size_t size)
{
    int32_t marks = 0;
    for (size_t i = 0; i < size;) {
        const ss_scene_place place = {b->override, (uint32_t)i, 1};
        const size_t length = ss_plain_length(text + i, size - i);
        if (length == 0) {
            refuse(b, place, "byte 0x%02x is no text; a scene is plain text in UTF-8",
                   (unsigned)(unsigned char)text[i]);
            return false;
        }
        if (text[i] == '%' && (i == 0 || text[i - 1] == '\n' || text[i - 1] == '\r')) {
            refuse(b, place, "directives are not taken in a scene; remove the line");
            return false;
        }
        marks += strchr("[{,!&*?", text[i]) != NULL;
        if (marks > SS_SCENE_MAX_NODES) {
            refuse(b, place, "more than %d values; put long lists into files of their own",
                   SS_SCENE_MAX_NODES);
            return false;
        }
        i += length;
    }
    return true;
}

/* Runs the parser over `text`; the root, or NULL after a fault. */
static ss_scene_node *build(ss_scene_tree *tree, ss_scene_report *report, int32_t override,
                            const char *text, size_t size)
{
    builder b = {.tree = tree, .report = report, .override = override};
    if (!is_plain_text(&b, text, size)) {
        return NULL;
    }
    struct fy_diag_cfg diag_config;
    fy_diag_cfg_default(&diag_config);
    diag_config.fp = NULL; /* collected, never printed */
    struct fy_diag *diag = fy_diag_create(&diag_config);
    if (diag == NULL) {
        refuse(&b, (ss_scene_place){override, 0, 0}, "out of memory");
        return NULL;
    }
    fy_diag_set_collect_errors(diag, true);
    const struct fy_parse_cfg config = {
        .search_path = "", .flags = FYPCF_QUIET | FYPCF_COLLECT_DIAG, .diag = diag};
    struct fy_parser *parser = fy_parser_create(&config);
    if (parser == NULL || fy_parser_set_string(parser, text, size) != 0) {
        refuse(&b, (ss_scene_place){override, 0, 0}, "out of memory");
    }
    struct fy_event *event = NULL;
    while (!b.is_bad && (event = fy_parser_parse(parser)) != NULL) {
        take_event(&b, event);
        fy_parser_event_free(parser, event);
    }
    if (!b.is_bad && fy_parser_get_stream_error(parser)) {
        refuse_syntax(&b, diag, text, size);
    }
    fy_parser_destroy(parser);
    fy_diag_destroy(diag);
    return b.is_bad ? NULL : b.root;
}

bool ss_scene_tree_parse(ss_scene_tree *tree, ss_scene_report *report, const char *text,
                         size_t size)
{
    const ss_scene_place start = {-1, 0, 0};
    if (size > SS_SCENE_MAX_BYTES) {
        ss_scene_report_add(report, SOFTSIM_ERROR_FORMAT, start,
                            "larger than %d MB; put long lists into files of their own",
                            SS_SCENE_MAX_BYTES >> 20);
        return false;
    }
    const int32_t before = ss_scene_report_total(report);
    tree->root = build(tree, report, -1, text, size);
    if (tree->root != NULL && tree->root->kind != SS_SCENE_MAP) {
        ss_scene_node_fault(report, tree->root,
                            "a scene is a mapping of keys; begin it with softsim: 1");
        tree->root = NULL;
    }
    if (tree->root == NULL && ss_scene_report_total(report) == before) {
        ss_scene_report_add(report, SOFTSIM_ERROR_FORMAT, start,
                            "the scene is empty; begin it with softsim: 1");
    }
    return tree->root != NULL;
}

/* ---- overrides ---- */

/* The next component of a path ("tools", "0" of "tools.0" and of "tools[0]"); false at a
 * malformed one. */
static bool next_component(const char **cursor, const char *end, char *out, size_t size)
{
    const char *at = *cursor;
    size_t used = 0;
    while (at < end && *at != '.' && *at != '[' && *at != ']' && used + 1 < size) {
        out[used++] = *at++;
    }
    out[used] = '\0';
    if (at < end && *at == ']') {
        at++;
    }
    if (used == 0 || (at < end && *at != '.' && *at != '[')) {
        return false;
    }
    *cursor = at < end ? at + 1 : at;
    return at == end || *cursor < end;
}

static ss_scene_node *child_of(ss_scene_node *node, const char *name)
{
    if (node->kind == SS_SCENE_MAP) {
        return ss_scene_node_find(node, name);
    }
    double number = 0;
    if (ss_scene_parse_number(name, &number) != SS_SCENE_GOOD || number < 0 ||
        number >= node->count || number != floor(number)) {
        return NULL;
    }
    ss_scene_node *child = node->first;
    for (int32_t i = 0; i < (int32_t)number; i++) {
        child = child->next;
    }
    return child;
}

ss_scene_node *ss_scene_node_locate(ss_scene_node *node, const char *path, const char *end,
                                    const char **out_rest)
{
    const char *cursor = path;
    bool is_there = true;
    *out_rest = path;
    for (int depth = 0; cursor < end; depth++) {
        char name[80];
        if (depth == SS_SCENE_MAX_DEPTH || !next_component(&cursor, end, name, sizeof name)) {
            return NULL;
        }
        ss_scene_node *child =
            is_there && node->kind != SS_SCENE_SCALAR ? child_of(node, name) : NULL;
        is_there = child != NULL;
        node = is_there ? child : node;
        *out_rest = is_there ? cursor : *out_rest;
    }
    return node;
}

/* A copy of `node` becomes `with`, in place. */
static void replace(ss_scene_node *node, const ss_scene_node *with)
{
    node->kind = with->kind;
    node->is_quoted = with->is_quoted;
    node->is_faulty = false;
    node->count = with->count;
    node->override = with->override;
    node->text = with->text;
    node->first = with->first;
    node->last = with->last;
    for (ss_scene_node *child = node->first; child != NULL; child = child->next) {
        child->parent = node;
    }
}

static ss_scene_node *parse_value(ss_scene_tree *tree, ss_scene_report *report, int32_t index,
                                  const char *text)
{
    if (text[0] == '[' || text[0] == '{') {
        return build(tree, report, index, text, strlen(text));
    }
    ss_scene_node *node = take_node(tree, SS_SCENE_SCALAR, index);
    if (node != NULL) {
        node->text = take_text(tree, text, strlen(text));
    }
    if (node == NULL || node->text == NULL) {
        ss_scene_report_add(report, SOFTSIM_ERROR_MEMORY, (ss_scene_place){index, 0, 0},
                            "out of memory");
        return NULL;
    }
    return node;
}

void ss_scene_tree_override(ss_scene_tree *tree, ss_scene_report *report, int32_t index)
{
    const ss_scene_place place = {index, 0, 0};
    const char *option = report->overrides[index];
    const char *equals = strchr(option, '=');
    if (equals == NULL || equals == option || equals[1] == '\0' || strlen(option) > 65536) {
        ss_scene_report_add(report, SOFTSIM_ERROR_ARGUMENT, place,
                            "give PATH=VALUE, such as haptic.max_force_n=3");
        return;
    }
    ss_scene_node *node = tree->root;
    const char *cursor = option;
    for (int depth = 0; cursor < equals; depth++) {
        char name[80];
        char path[256];
        if (!next_component(&cursor, equals, name, sizeof name) || depth == SS_SCENE_MAX_DEPTH) {
            ss_scene_report_add(report, SOFTSIM_ERROR_ARGUMENT, place,
                                "'%.*s' is not a path; write keys and list numbers with dots "
                                "between, such as contact.tools.0.probe",
                                (int)(equals - option), option);
            return;
        }
        if (node->kind == SS_SCENE_SCALAR) {
            /* An empty value in the file is an empty mapping to build on. */
            if (node->text[0] != '\0' || node->is_quoted) {
                ss_scene_node_path(node, path, sizeof path);
                ss_scene_report_add(report, SOFTSIM_ERROR_ARGUMENT, place,
                                    "%s is a value and has no '%s' below it", path, name);
                return;
            }
            node->kind = SS_SCENE_MAP;
        }
        ss_scene_node *child = child_of(node, name);
        if (child == NULL && node->kind == SS_SCENE_LIST) {
            ss_scene_node_path(node, path, sizeof path);
            ss_scene_report_add(report, SOFTSIM_ERROR_ARGUMENT, place,
                                "%s has no entry '%s'; it has %d, numbered from 0", path, name,
                                (int)node->count);
            return;
        }
        if (child == NULL) {
            child = take_node(tree, SS_SCENE_MAP, index);
            const char *key = take_text(tree, name, strlen(name));
            if (child == NULL || key == NULL || node->count >= SS_SCENE_MAX_KEYS) {
                ss_scene_report_add(report, SOFTSIM_ERROR_MEMORY, place, "out of memory");
                return;
            }
            child->key = key;
            append(node, child);
        }
        node = child;
    }
    const ss_scene_node *value = parse_value(tree, report, index, equals + 1);
    if (value != NULL) {
        replace(node, value);
    } else {
        node->is_faulty = true;
    }
}
