/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A scene's file with other values in it.
 *
 * The text is edited, not printed again: comments, order and layout are the user's, and a value
 * that changes says at the end of its line what it was, since they may tell of that. Each
 * assignment is one edit of the bytes that the tree says its value has, and the tree is read again
 * after it, so that the next finds what the last has added. Rejected: printing the tree (comments
 * are lost), and all edits in one go (two new keys of one new mapping would write the mapping
 * twice).
 */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/region.h"
#include "scene/source.h"

typedef struct rewriter {
    const char *path; /* of the scene, for faults */
    softsim_error *error;
    ss_scene_report *report;
    char *text;
    size_t size;
    ss_scene_tree tree; /* of the text */
} rewriter;

static bool fault_memory(const rewriter *r)
{
    softsim_error_add(r->error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", r->path);
    return false;
}

/* Reads the tree of the text as it is now. */
static bool parse(rewriter *r)
{
    ss_scene_tree_fini(&r->tree);
    *r->report = (ss_scene_report){.path = r->path, .source = r->text, .size = r->size};
    const bool is_good = ss_scene_tree_parse(&r->tree, r->report, r->text, r->size);
    ss_scene_report_flush(r->report, r->error);
    return is_good;
}

/* Puts `with` in the place of `length` bytes. */
static bool splice(rewriter *r, size_t offset, size_t length, const char *with)
{
    const size_t added = strlen(with), size = r->size - length + added;
    char *text = malloc(size + 1);
    if (text == NULL) {
        return fault_memory(r);
    }
    memcpy(text, r->text, offset);
    memcpy(text + offset, with, added);
    memcpy(text + offset + added, r->text + offset + length, r->size - offset - length);
    text[size] = '\0';
    free(r->text);
    r->text = text;
    r->size = size;
    return true;
}

/* Quotes on either side of a scalar. The tree's place of one in quotes lies between them: they go
 * with it, as what takes its place brings its own. */
static size_t quotes_of(const rewriter *r, const ss_scene_node *node)
{
    const char before = node->is_quoted && node->offset > 0 ? r->text[node->offset - 1] : ' ';
    return before == '"' || before == '\'' ? 1 : 0; /* none: a block of lines */
}

/* Puts `with` in the place of a scalar. */
static bool replace(rewriter *r, const ss_scene_node *node, const char *with)
{
    const size_t quote = quotes_of(r, node);
    return splice(r, node->offset - quote, node->length + 2 * quote, with);
}

/* ---- one assignment ---- */

/* A value as an assignment gives it: lists and mappings as they are, else one scalar. */
static void put_value(FILE *stream, const char *value)
{
    if (value[0] == '[' || value[0] == '{') {
        fputs(value, stream);
    } else {
        ss_scene_put_text(stream, value, false);
    }
}

/* "b: {c: VALUE}" for what is left of a path. */
static void put_rest(FILE *stream, const char *rest, const char *end, const char *value)
{
    int depth = 0;
    for (const char *at = rest; at < end;) {
        const size_t length = strcspn(at, ".[]=");
        fprintf(stream, "%s%.*s: ", depth > 0 ? "{" : "", (int)length, at);
        at += length;
        at += at < end;
        ++depth;
    }
    put_value(stream, value);
    for (; depth > 1; --depth) {
        fputc('}', stream);
    }
}

static size_t line_start(const rewriter *r, size_t offset)
{
    while (offset > 0 && r->text[offset - 1] != '\n') {
        --offset;
    }
    return offset;
}

/* Where a new key of `map` goes and what stands around it there. A flow mapping takes it behind its
 * first value or its brace, a block mapping on the line behind its first value, or before its
 * first key where that is no scalar of one line. */
static size_t choose_place(const rewriter *r, const ss_scene_node *map, char *before, char *after,
                           size_t room)
{
    const ss_scene_node *first = map->first;
    const bool is_short =
        first != NULL && first->kind == SS_SCENE_SCALAR && !first->is_quoted && first->length > 0;
    before[0] = after[0] = '\0';
    if (r->text[map->offset] == '{') {
        if (is_short) {
            snprintf(before, room, ", ");
            return first->offset + first->length;
        }
        snprintf(after, room, "%s", first != NULL ? ", " : "");
        return map->offset + 1;
    }
    const size_t indent = first->key_offset - line_start(r, first->key_offset);
    if (is_short) {
        snprintf(before, room, "\n%*s", (int)indent, "");
        const size_t end = first->offset + first->length;
        return end + strcspn(r->text + end, "\n");
    }
    snprintf(after, room, "\n%*s", (int)indent, "");
    return first->key_offset;
}

/* Is `at` in the middle of a scalar? */
static bool is_within_scalar(const ss_scene_node *node, size_t at)
{
    bool is_within = node->kind == SS_SCENE_SCALAR && node->offset < at &&
                     at < node->offset + node->length + node->is_quoted;
    for (const ss_scene_node *child = node->first; child != NULL && !is_within;
         child = child->next) {
        is_within = is_within_scalar(child, at);
    }
    return is_within;
}

/* Takes out of the line's end, from `from`, the number that was told of the same scalar before, as
 * `note` tells it. Words may be a user's own: they stay. */
static bool unmark(rewriter *r, size_t from, size_t *end, const char *note)
{
    const size_t begins = (size_t)(strstr(note, "was ") - note) + strlen("was ");
    for (size_t at = from; at + begins < *end; ++at) {
        char *behind = NULL;
        if (memcmp(r->text + at, note, begins) != 0 || is_within_scalar(r->tree.root, at)) {
            continue;
        }
        (void)strtod(r->text + at + begins, &behind);
        const size_t length = (size_t)(behind - r->text) - at;
        const char *rest = r->text + at + length;
        if (length > begins && at + length <= *end &&
            (at + length == *end || strncmp(rest, "  # ", 4) == 0)) {
            *end -= length;
            return splice(r, at, length, "");
        }
    }
    return true;
}

/* Says at the end of the line what a scalar was that `with` is to replace: comments beside a value
 * are the user's and stay, and where they tell of the old one they are not told of the new. Nothing
 * where no comment can stand, or nothing changes. */
static bool mark(rewriter *r, const ss_scene_node *node, const char *with)
{
    const size_t quote = quotes_of(r, node), begin = node->offset - quote;
    const size_t length = node->length + 2 * quote;
    size_t end = begin + length + strcspn(r->text + begin + length, "\r\n");
    const size_t line = line_start(r, begin);
    const bool is_first = line + strspn(r->text + line, " -") == node->key_offset;
    char *note = NULL;
    if ((strlen(with) == length && memcmp(with, r->text + begin, length) == 0) ||
        memchr(r->text + begin, '\n', length) != NULL || is_within_scalar(r->tree.root, end)) {
        return true;
    }
    const char *key = node->key != NULL && !is_first ? node->key : "";
    if (asprintf(&note, "  # %s%swas %.*s", key, key[0] != '\0' ? " " : "", (int)length,
                 r->text + begin) < 0) {
        return fault_memory(r);
    }
    const bool is_good = unmark(r, begin + length, &end, note) && splice(r, end, 0, note);
    free(note);
    return is_good;
}

static bool assign(rewriter *r, const char *assignment)
{
    const char *equals = strchr(assignment, '='), *rest = NULL;
    const ss_scene_node *node = parse(r) && equals != NULL
                                    ? ss_scene_node_locate(r->tree.root, assignment, equals, &rest)
                                    : NULL;
    if (node == NULL) {
        softsim_error_add(r->error, SOFTSIM_ERROR_ARGUMENT, "%s: '%s' cannot be written", r->path,
                          assignment);
        return false;
    }
    const bool is_empty = node->kind == SS_SCENE_SCALAR && node->length == 0 && !node->is_quoted;
    if (rest == equals && node->kind != SS_SCENE_SCALAR) {
        softsim_error_add(r->error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: %.*s is a list or a mapping there, which cannot be replaced in its "
                          "place; write '%s' into the file",
                          r->path, (int)(equals - assignment), assignment, assignment);
        return false;
    }
    char before[64] = "", after[64] = "";
    char *with = NULL;
    size_t length = 0, offset = node->offset;
    if (is_empty) { /* behind the colon of its key */
        snprintf(before, sizeof before, " ");
        offset = node->key_offset + node->key_length;
        offset += strcspn(r->text + offset, ":") + 1;
    } else if (rest < equals) {
        offset = choose_place(r, node, before, after, sizeof before);
    }
    FILE *stream = open_memstream(&with, &length);
    if (stream == NULL) {
        return fault_memory(r);
    }
    fputs(before, stream);
    fputs(is_empty && rest < equals ? "{" : "", stream);
    if (rest < equals) {
        put_rest(stream, rest, equals, equals + 1);
    } else {
        put_value(stream, equals + 1);
    }
    fputs(is_empty && rest < equals ? "}" : "", stream);
    fputs(after, stream);
    const bool is_good =
        fclose(stream) == 0 &&
        (rest < equals || is_empty ? splice(r, offset, 0, with)
                                   : mark(r, node, with) && replace(r, node, with));
    free(with);
    return is_good;
}

/* ---- files ---- */

/* Makes the names of files absolute, the last first so that what is before keeps its place. `like`
 * is the same value of the loaded scene, whose tables know which texts are names of files. */
static bool move_files(rewriter *r, const ss_scene_node *node, const ss_scene_node *like,
                       const char *folder)
{
    if (node->kind == SS_SCENE_SCALAR) {
        char path[2 * PATH_MAX], *with = NULL;
        size_t size = 0;
        if (!like->is_path || !ss_scene_join_path(folder, node->text, path, sizeof path)) {
            return true;
        }
        FILE *stream = open_memstream(&with, &size);
        if (stream == NULL) {
            return fault_memory(r);
        }
        ss_scene_put_text(stream, path, true);
        const bool is_good = fclose(stream) == 0 && replace(r, node, with);
        free(with);
        return is_good;
    }
    for (int32_t i = node->count - 1; i >= 0; --i) {
        const ss_scene_node *child = node->first, *twin = like->first;
        for (int32_t k = 0; k < i; ++k) {
            child = child->next;
        }
        for (int32_t k = 0; like->kind == SS_SCENE_LIST && k < i && twin != NULL; ++k) {
            twin = twin->next;
        }
        twin = like->kind == SS_SCENE_MAP && child->key != NULL
                   ? ss_scene_node_find(like, child->key)
                   : twin;
        if (twin != NULL && twin->kind == child->kind && !move_files(r, child, twin, folder)) {
            return false;
        }
    }
    return true;
}

/* The folders as absolute paths, ending in /. */
static bool resolve(const char *folder, char out[PATH_MAX + 1])
{
    if (realpath(folder[0] != '\0' ? folder : ".", out) == NULL) {
        return false;
    }
    const size_t length = strlen(out);
    if (length > 1 && length < PATH_MAX) {
        memcpy(out + length, "/", 2);
    }
    return true;
}

char *ss_scene_rewrite(const ss_scene *scene, const char *const *assignments, int32_t count,
                       const char *folder, softsim_error *error)
{
    rewriter r = {.path = scene->path, .error = error};
    char from[PATH_MAX + 1], to[PATH_MAX + 1];
    r.report = calloc(1, sizeof *r.report);
    r.text = ss_scene_read_file(scene->path, &r.size, error);
    bool is_good = r.text != NULL && (r.report != NULL || fault_memory(&r));
    for (int32_t i = 0; is_good && i < count; ++i) {
        is_good = assign(&r, assignments[i]);
    }
    if (is_good && (!resolve(scene->source->folder, from) || !resolve(folder, to))) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: the folder '%s' is not there",
                          scene->path, folder);
        is_good = false;
    }
    is_good =
        is_good && parse(&r) &&
        (strcmp(from, to) == 0 || move_files(&r, r.tree.root, scene->source->tree.root, from));
    ss_scene_tree_fini(&r.tree);
    free(r.report);
    if (!is_good) {
        free(r.text);
        return NULL;
    }
    return r.text;
}

/* ---- outputs ---- */

/* The file that a text names, and the one that is read with it. */
static bool check_file(const char *folder, const char *text, const ss_named_file *output,
                       int32_t output_count, softsim_error *error)
{
    char path[2 * PATH_MAX], pair[2 * PATH_MAX];
    const ss_named_file input[] = {{"a file of the scene", path}, {"a file of the scene", pair}};
    return !ss_scene_join_path(folder, text, path, sizeof path) ||
           ss_files_check(input, ss_mesh_name_pair(path, pair, sizeof pair) ? 2 : 1, output,
                          output_count, error);
}

static bool check_outputs(const ss_scene_node *node, const char *folder,
                          const ss_named_file *output, int32_t output_count, softsim_error *error)
{
    bool is_good = !node->is_path || check_file(folder, node->text, output, output_count, error);
    for (const ss_scene_node *at = node->first; at != NULL && is_good; at = at->next) {
        is_good = check_outputs(at, folder, output, output_count, error);
    }
    return is_good;
}

bool ss_scene_check_outputs(const ss_scene *scene, const ss_named_file *output,
                            int32_t output_count, softsim_error *error)
{
    return check_outputs(scene->source->tree.root, scene->source->folder, output, output_count,
                         error);
}

/* ---- reading ---- */

bool ss_scene_find_number(const ss_scene *scene, const ss_scene_model *model, const char *path,
                          double *out_value)
{
    const char *end = path + strlen(path), *rest = NULL;
    const ss_scene_node *node = ss_scene_node_locate(scene->source->tree.root, path, end, &rest);
    if (node != NULL && rest == end) {
        return node->kind == SS_SCENE_SCALAR && !node->is_quoted &&
               ss_scene_parse_number(node->text, out_value) == SS_SCENE_GOOD;
    }
    for (int32_t i = 0; node != NULL && i < model->row_count; ++i) {
        const ss_param_row *row = &model->row[i];
        if (strncmp(path, "model.", 6) == 0 && strcmp(path + 6, row->name) == 0 &&
            (row->kind == SS_PARAM_NUMBER || row->kind == SS_PARAM_FIELD) &&
            isfinite(row->fallback)) {
            *out_value = row->fallback;
            return true;
        }
    }
    return false;
}
