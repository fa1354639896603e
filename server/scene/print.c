/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The effective scene as YAML, and the assignments that reach a running one. Both walk the tables
 * of keys, so that what is printed is what can be written.
 *
 * Plain values come from ss_scene (defaults included), lists and regions from the tree as they
 * were written. File names are made absolute: the output loads again from any folder.
 */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/plain.h"
#include "scene/region.h"
#include "scene/source.h"

enum { COMMENT_COLUMN = 40 };

typedef struct printer {
    void (*line)(void *sink, const char *text);
    void *sink;
    FILE *stream; /* the line being built */
    char *buffer;
    size_t size;
    char folder[PATH_MAX]; /* absolute, ending in / */
    const ss_scene *scene;
} printer;

/* ---- lines ---- */

static void begin(printer *p, int indent)
{
    rewind(p->stream);
    fprintf(p->stream, "%*s", 2 * indent, "");
}

/* Ends the line, with a comment in a column of its own where there is one. */
static void end(printer *p, const char *comment)
{
    fflush(p->stream);
    if (comment[0] != '\0') {
        const long used = ftell(p->stream);
        fprintf(p->stream, "%*s# %s", used < COMMENT_COLUMN ? (int)(COMMENT_COLUMN - used) : 1, "",
                comment);
    }
    fputc('\0', p->stream);
    fflush(p->stream);
    p->line(p->sink, p->buffer);
}

void ss_scene_put_number(FILE *stream, double value)
{
    char text[40];
    if (value == floor(value) && fabs(value) < 1e15) {
        fprintf(stream, "%.0f", value);
        return;
    }
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value) {
            break;
        }
    }
    const size_t mantissa = strcspn(text, "e");
    const bool is_bare = text[mantissa] == 'e' && memchr(text, '.', mantissa) == NULL;
    fprintf(stream, "%.*s%s%s", (int)mantissa, text, is_bare ? ".0" : "", text + mantissa);
}

void ss_scene_put_text(FILE *stream, const char *text, bool is_quoted)
{
    const size_t plain = strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                      "0123456789_./+-");
    if (!is_quoted && text[0] != '\0' && text[plain] == '\0' && strcmp(text, "-") != 0 &&
        strncmp(text, "---", 3) != 0 && strncmp(text, "...", 3) != 0) {
        fputs(text, stream);
        return;
    }
    fputc('"', stream);
    for (size_t left = strlen(text); left > 0;) {
        const unsigned char *c = (const unsigned char *)text;
        const size_t length = ss_plain_length(text, left);
        const size_t taken = length > 0 ? length : 1;
        if (*c == '"' || *c == '\\') {
            fprintf(stream, "\\%c", *c);
        } else if (ss_plain_is_shown(text, length)) {
            fwrite(text, 1, taken, stream);
        } else if (length == 3) {
            fprintf(stream, "\\u%04x", (c[0] & 0xfu) << 12 | (c[1] & 0x3fu) << 6 | (c[2] & 0x3fu));
        } else {
            fprintf(stream, "\\x%02x", c[taken - 1]); /* of two bytes: U+0080 to U+009F */
        }
        text += taken;
        left -= taken;
    }
    fputc('"', stream);
}

static void put_scalar(printer *p, const ss_scene_node *node)
{
    char path[2 * PATH_MAX];
    if (node->is_path && ss_scene_join_path(p->folder, node->text, path, sizeof path)) {
        ss_scene_put_text(p->stream, path, true);
    } else {
        ss_scene_put_text(p->stream, node->text, node->is_quoted);
    }
}

/* A node as it was written, on one line. */
static void put_flow(printer *p, const ss_scene_node *node)
{
    if (node->kind == SS_SCENE_SCALAR) {
        put_scalar(p, node);
        return;
    }
    const bool is_map = node->kind == SS_SCENE_MAP;
    fputc(is_map ? '{' : '[', p->stream);
    for (const ss_scene_node *child = node->first; child != NULL; child = child->next) {
        if (is_map) {
            fprintf(p->stream, "%s: ", child->key);
        }
        put_flow(p, child);
        if (child->next != NULL) {
            fputs(", ", p->stream);
        }
    }
    fputc(is_map ? '}' : ']', p->stream);
}

/* ---- rows ---- */

static void put_value(FILE *stream, const ss_scene_row *row, double value)
{
    char word[64];
    if (row->kind == SS_SCENE_CHOICE || row->kind == SS_SCENE_BOOL) {
        const char *words = row->kind == SS_SCENE_BOOL ? "false|true" : row->choices;
        ss_scene_choice_name(words, (int32_t)value, word, sizeof word);
        fputs(word, stream);
    } else if (row->kind == SS_SCENE_RATE && value == 0) {
        fputs("auto", stream);
    } else {
        ss_scene_put_number(stream, value);
    }
}

/* "help; range; default D; live" */
static void comment_of(const ss_scene_row *row, char *out, size_t size)
{
    char text[512];
    char standard[64] = "";
    ss_scene_describe(row, text, sizeof text);
    FILE *stream = fmemopen(standard, sizeof standard, "w");
    if (stream != NULL) {
        if (row->is_required) {
            fputs("required", stream);
        } else if (isnan(row->fallback)) {
            fputs("absent unless given", stream);
        } else if (row->kind <= SS_SCENE_RATE || row->kind == SS_SCENE_FIELD ||
                   row->kind == SS_SCENE_VECTOR) {
            fputs("default ", stream);
            put_value(stream, row, row->fallback);
        }
        fclose(stream);
    }
    const bool is_described = row->kind == SS_SCENE_TEXT || row->kind == SS_SCENE_FILE;
    snprintf(out, size, "%s%s%s%s%s; %s", row->help != NULL ? row->help : "",
             is_described ? "" : "; ", is_described ? "" : text, standard[0] != '\0' ? "; " : "",
             standard, row->live > 0 ? "live" : "restart");
}

/* A row bound to a field of ss_scene. */
static void put_field(printer *p, const ss_scene_row *row)
{
    const char *field = (const char *)p->scene + row->field - 1;
    double value[3] = {0, 0, 0};
    if (row->kind == SS_SCENE_INTEGER || row->kind == SS_SCENE_CHOICE) {
        int32_t whole = 0;
        memcpy(&whole, field, sizeof whole);
        value[0] = whole;
    } else {
        memcpy(value, field, (row->kind == SS_SCENE_VECTOR ? 3 : 1) * sizeof *value);
    }
    if (row->kind == SS_SCENE_VECTOR) {
        fputc('[', p->stream);
        for (int k = 0; k < 3; k++) {
            ss_scene_put_number(p->stream, value[k]);
            fputs(k < 2 ? ", " : "]", p->stream);
        }
    } else {
        put_value(p->stream, row, value[0]);
    }
}

/* Is there anything to print for a row without a node? */
static bool has_default(const ss_scene_row *row)
{
    return (row->kind <= SS_SCENE_RATE || row->kind == SS_SCENE_FIELD) && row->one_of == 0 &&
           !row->is_required;
}

static void print_table(printer *p, int indent, ss_scene_table table, const ss_scene_node *map);

static void print_row(printer *p, int indent, const ss_scene_row *row, const ss_scene_node *node)
{
    char comment[1024];
    comment_of(row, comment, sizeof comment);
    begin(p, indent);
    if (node == NULL && isnan(row->fallback)) {
        fprintf(p->stream, "# %s:", row->name);
        end(p, comment);
        return;
    }
    fprintf(p->stream, "%s:", row->name);
    if (row->kind == SS_SCENE_ENTRIES) {
        end(p, comment);
        for (const ss_scene_node *item = node->first; item != NULL; item = item->next) {
            begin(p, indent + 1);
            fputs("- ", p->stream);
            put_flow(p, item);
            end(p, "");
        }
        return;
    }
    if (row->kind == SS_SCENE_KEYS) {
        end(p, "");
        print_table(p, indent + 1, row->child, node);
        return;
    }
    fputc(' ', p->stream);
    if (row->field > 0) {
        put_field(p, row);
    } else if (node != NULL) {
        put_flow(p, node);
    } else if (row->kind == SS_SCENE_VECTOR) {
        fputs("[0, 0, 0]", p->stream);
    } else {
        put_value(p->stream, row, row->fallback);
    }
    end(p, comment);
}

/* Keys that exclude one another: the working force is silent beside a given stiffness. */
static bool is_printed(const ss_scene_row *row, const ss_scene_node *node, const ss_scene_node *map)
{
    if (row->needs != NULL && ss_scene_node_find(map, row->needs) == NULL) {
        return false;
    }
    if (row->one_of != 0 && row->kind == SS_SCENE_KEYS) {
        return node != NULL;
    }
    if (row->kind == SS_SCENE_ENTRIES) {
        return node != NULL && node->count > 0;
    }
    if (row->one_of != 0 && row->field > 0) {
        return strcmp(row->name, "working_force_n") == 0
                   ? ss_scene_node_find(map, "stiffness_n_per_m3") == NULL
                   : node != NULL;
    }
    return node != NULL || has_default(row) || row->kind == SS_SCENE_KEYS ||
           row->kind == SS_SCENE_VECTOR;
}

/* `name`, then a line for every row of the model: a comment where it is absent. */
static void print_model(printer *p, const ss_scene_node *map)
{
    const struct ss_scene_source *source = p->scene->source;
    char comment[1024];
    begin(p, 0);
    fputs("model:", p->stream);
    end(p, "");
    begin(p, 1);
    fprintf(p->stream, "name: %s", p->scene->model_name);
    end(p, "restart");
    for (int32_t i = 1; i < source->model_row_count; i++) {
        const ss_scene_row *row = &source->model_row[i];
        const ss_param_value *value = &p->scene->param[i - 1];
        const char *dot = strchr(row->name, '.');
        const char *name = dot != NULL ? dot + 1 : row->name;
        const size_t prefix = (size_t)(name - row->name); /* dot included */
        if (dot != NULL && strncmp(source->model_row[i - 1].name, row->name, prefix) != 0) {
            begin(p, 1);
            fprintf(p->stream, "%.*s:", (int)prefix - 1, row->name);
            end(p, "");
        }
        comment_of(row, comment, sizeof comment);
        begin(p, dot != NULL ? 2 : 1);
        const bool is_direction = row->kind == SS_SCENE_DIRECTION;
        const bool is_flow = value->per_node != NULL || value->by_element != NULL ||
                             value->per_link != NULL || (is_direction && value->is_given);
        if (!is_flow && isnan(value->number)) {
            fprintf(p->stream, "# %s:", name);
        } else if (is_flow) {
            fprintf(p->stream, "%s: ", name);
            put_flow(p, ss_scene_find_model_node(map, row->name));
        } else {
            fprintf(p->stream, "%s: ", name);
            put_value(p->stream, row, value->number);
        }
        end(p, comment);
    }
}

/* A row's example, commented out, line by line; behind its name where there is nothing else. */
static void print_example(printer *p, int indent, const ss_scene_row *row, const char *name)
{
    for (const char *at = row->example != NULL ? row->example : ""; *at != '\0';) {
        const int length = (int)strcspn(at, "\n");
        begin(p, indent);
        fprintf(p->stream, "# %s%s%.*s", name, name[0] != '\0' ? ": " : "", length, at);
        end(p, "");
        at += length + (at[length] == '\n');
    }
}

/* A key that the scene leaves out and that has no default to print. */
static void print_absent(printer *p, int indent, const ss_scene_row *row)
{
    char comment[1024];
    comment_of(row, comment, sizeof comment);
    begin(p, indent);
    fprintf(p->stream, "# %s:", row->name);
    end(p, comment);
    if (row->kind == SS_SCENE_ENTRIES) {
        print_example(p, indent + 1, row, "");
    } else {
        print_example(p, indent, row, row->name);
    }
}

static void print_table(printer *p, int indent, ss_scene_table table, const ss_scene_node *map)
{
    for (int32_t i = 0; i < table.count; i++) {
        const ss_scene_row *row = &table.row[i];
        const ss_scene_node *node = ss_scene_node_find(map, row->name);
        if (row->kind == SS_SCENE_MODEL) {
            print_model(p, node);
        } else if (is_printed(row, node, map)) {
            print_row(p, indent, row, node);
            if (row->kind == SS_SCENE_ENTRIES) {
                print_example(p, indent + 1, row, "");
            } else if (row->kind == SS_SCENE_KEYS) {
                print_example(p, indent, row, row->name);
            }
        } else if (row->needs == NULL || ss_scene_node_find(map, row->needs) != NULL) {
            print_absent(p, indent, row);
        }
    }
}

static bool open_printer(printer *p, const ss_scene *scene,
                         void (*line)(void *sink, const char *text), void *sink)
{
    *p = (printer){.line = line, .sink = sink, .scene = scene};
    const char *folder = scene->source->folder;
    if (realpath(folder[0] != '\0' ? folder : ".", p->folder) == NULL) {
        snprintf(p->folder, sizeof p->folder, "%s", folder);
    } else if (p->folder[1] != '\0' && strlen(p->folder) + 1 < sizeof p->folder) {
        strcat(p->folder, "/");
    }
    p->stream = open_memstream(&p->buffer, &p->size);
    return p->stream != NULL;
}

static void close_printer(printer *p)
{
    fclose(p->stream);
    free(p->buffer);
}

void ss_scene_print(const ss_scene *scene, const ss_scene_model *model,
                    void (*line)(void *sink, const char *text), void *sink)
{
    (void)model; /* its rows are kept with the scene */
    printer p;
    if (open_printer(&p, scene, line, sink)) {
        print_table(&p, 0, ss_scene_root, scene->source->tree.root);
        close_printer(&p);
    }
}

void ss_scene_print_given(const ss_scene *scene, const char *key,
                          void (*line)(void *sink, const char *text), void *sink)
{
    printer p;
    const ss_scene_node *map = ss_scene_node_find(scene->source->tree.root, key);
    if (map == NULL || map->kind != SS_SCENE_MAP || !open_printer(&p, scene, line, sink)) {
        return;
    }
    for (const ss_scene_node *node = map->first; node != NULL; node = node->next) {
        begin(&p, 1);
        fprintf(p.stream, "%s: ", node->key);
        put_flow(&p, node);
        end(&p, "");
    }
    close_printer(&p);
}

/* ---- while running ---- */

/* The row of a dotted path below `table`; NULL with a fault. */
static const ss_scene_row *find_path(ss_scene_table table, const char *path, softsim_error *error)
{
    for (;;) {
        char name[80];
        const size_t length = strcspn(path, ".");
        snprintf(name, sizeof name, "%.*s", (int)(length < 79 ? length : 79), path);
        const ss_scene_row *row = ss_scene_find_row(table, name);
        if (row == NULL) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "set: there is no key '%s'; --print-config lists them", name);
            return NULL;
        }
        if (path[length] == '\0' || row->kind == SS_SCENE_ENTRIES ||
            (row->kind == SS_SCENE_MODEL && strcmp(path, "model.name") == 0)) {
            return row;
        }
        table = row->child; /* empty below a plain value, so that nothing is found there */
        path += length + 1;
    }
}

static bool find_model_row(const ss_scene_model *model, const char *path, ss_scene_row *out_row,
                           int32_t *out_index)
{
    const size_t prefix = strlen("model.");
    const bool is_model = model != NULL && strncmp(path, "model.", prefix) == 0;
    for (int32_t i = 0; is_model && i < model->row_count; i++) {
        if (strcmp(model->row[i].name, path + prefix) == 0) {
            *out_row = ss_scene_row_of_param(&model->row[i]);
            *out_index = i;
            return true;
        }
    }
    return false;
}

/* A value of a row as it is written, without its unit. */
static void write_value(const ss_scene_row *row, double value, char *out, size_t size)
{
    if (row->kind == SS_SCENE_CHOICE) {
        ss_scene_choice_name(row->choices, (int32_t)value, out, size);
    } else if (row->kind == SS_SCENE_BOOL) {
        snprintf(out, size, "%s", value != 0.0 ? "true" : "false");
    } else {
        snprintf(out, size, "%.6g", value);
    }
}

/* The scene's own value of a live row; false where it varies or is absent. */
static bool own_value(const ss_scene *scene, const ss_scene_row *row, int32_t model_row,
                      double *out)
{
    const ss_param_value *param = model_row >= 0 ? &scene->param[model_row] : NULL;
    if (param != NULL) {
        *out = param->number;
        return param->per_node == NULL && param->by_element == NULL && param->per_link == NULL &&
               isfinite(param->number);
    }
    const char *field = (const char *)scene + row->field - 1;
    *out = row->kind == SS_SCENE_CHOICE ? (double)*(const int32_t *)(const void *)field
                                        : *(const double *)(const void *)field;
    return true;
}

void ss_scene_tell_live(const ss_scene *scene, const ss_scene_model *model, const char *assignment,
                        double value, const double *before, char *out, size_t size)
{
    char path[128], now[64], then[64];
    softsim_error ignored = {.status = SOFTSIM_OK};
    ss_scene_row model_row;
    int32_t index = -1;
    double old = 0.0;
    snprintf(path, sizeof path, "%.*s", (int)strcspn(assignment, "="), assignment);
    const ss_scene_row *row = find_model_row(model, path, &model_row, &index)
                                  ? &model_row
                                  : find_path(ss_scene_root, path, &ignored);
    write_value(row, value, now, sizeof now);
    const char *unit = row->unit != NULL ? row->unit : "";
    const int length = snprintf(out, size, "%s = %s%s%s", path, now, *unit ? " " : "", unit);
    if (before == NULL && own_value(scene, row, index, &old)) {
        before = &old;
    }
    if (before != NULL && length > 0 && (size_t)length < size) {
        write_value(row, *before, then, sizeof then);
        snprintf(out + length, size - (size_t)length, " (was %s)", then);
    }
}

/* Live row number *left of a table and of those below it, counted down; NULL beyond the last. */
static const ss_scene_row *find_live(ss_scene_table table, int32_t *left, char *path, size_t size)
{
    const size_t length = strlen(path);
    for (int32_t i = 0; i < table.count; ++i) {
        const ss_scene_row *row = &table.row[i];
        snprintf(path + length, size - length, "%s%s", length > 0 ? "." : "", row->name);
        if (row->live > 0 && (*left)-- == 0) {
            return row;
        }
        if (row->kind == SS_SCENE_KEYS) {
            const ss_scene_row *found = find_live(row->child, left, path, size);
            if (found != NULL) {
                return found;
            }
        }
    }
    path[length] = '\0';
    return NULL;
}

bool ss_scene_find_live(const ss_scene_model *model, int32_t number, ss_scene_live *out_live)
{
    ss_scene_row model_row;
    *out_live = (ss_scene_live){.row = -1};
    const ss_scene_row *row =
        find_live(ss_scene_root, &number, out_live->path, sizeof out_live->path);
    for (int32_t i = 0; row == NULL && i < model->row_count; ++i) {
        if (model->row[i].is_live && number-- == 0) {
            snprintf(out_live->path, sizeof out_live->path, "model.%s", model->row[i].name);
            model_row = ss_scene_row_of_param(&model->row[i]);
            row = &model_row;
            out_live->row = i;
        }
    }
    if (row == NULL) {
        return false;
    }
    out_live->key = (ss_scene_live_key)(row->live - 1);
    return true;
}

void ss_scene_describe_live(const ss_scene *scene, const ss_scene_model *model,
                            const ss_scene_live *live, const double *set, double most, char *out,
                            size_t size)
{
    ss_scene_row model_row;
    softsim_error ignored = {.status = SOFTSIM_OK};
    int32_t index = -1;
    double value = set != NULL ? *set : 0.0;
    char now[64] = "varies";
    const ss_scene_row *row = find_model_row(model, live->path, &model_row, &index)
                                  ? &model_row
                                  : find_path(ss_scene_root, live->path, &ignored);
    if (set != NULL || own_value(scene, row, index, &value)) {
        write_value(row, value, now, sizeof now);
    }
    ss_range range = row->range;
    const char *unit = row->unit != NULL ? row->unit : "";
    if (row->kind == SS_SCENE_CHOICE || row->kind == SS_SCENE_BOOL) {
        unit = row->kind == SS_SCENE_BOOL ? "false|true" : row->choices;
        range = (ss_range){.max = 0.0};
        for (const char *at = unit; *at != '\0'; ++at) {
            range.max += *at == '|' ? 1.0 : 0.0;
        }
    }
    snprintf(out, size, "%s=%s %.6g %.6g %s", live->path, now, range.min, fmin(range.max, most),
             unit);
}

softsim_status ss_scene_parse_live(const char *assignment, const ss_scene_model *model,
                                   ss_scene_live_key *out_key, int32_t *out_row, double *out_value,
                                   softsim_error *error)
{
    char path[128];
    char why[96];
    char expected[320];
    const char *equals = strchr(assignment, '=');
    const size_t length = equals != NULL ? (size_t)(equals - assignment) : 0;
    if (length == 0 || length >= sizeof path) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "set: give PATH=VALUE, such as haptic.max_force_n=3");
        return SOFTSIM_ERROR_ARGUMENT;
    }
    snprintf(path, sizeof path, "%.*s", (int)length, assignment);
    *out_row = -1;
    ss_scene_row model_row;
    const ss_scene_row *row = &model_row;
    if (!find_model_row(model, path, &model_row, out_row)) {
        row = find_path(ss_scene_root, path, error);
    }
    if (row == NULL) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    if (row->live == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "set: %s cannot change while running; put it into the scene, or give "
                          "--set, and restart",
                          path);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    if (!ss_scene_read_scalar(row, equals + 1, false, out_value, why, sizeof why)) {
        ss_scene_describe(row, expected, sizeof expected);
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "set: %s %s; give %s", path, why,
                          expected);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    *out_key = (ss_scene_live_key)(row->live - 1);
    return SOFTSIM_OK;
}
