/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A tree against the tables: unknown and repeated keys, missing ones, types, ranges. Every fault
 * is reported and the walk goes on; what depends on the mesh is judged later, in scene.c.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/each.h"
#include "scene/schema.h"

enum { PATH_SIZE = 256, TEXT_SIZE = 320 };

/* ---- faults ---- */

static void fault_value(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node,
                        const char *why)
{
    char path[PATH_SIZE];
    char expected[TEXT_SIZE];
    ss_scene_node_path(node, path, sizeof path);
    ss_scene_describe(row, expected, sizeof expected);
    if (node->kind == SS_SCENE_SCALAR && node->length == 0 && node->override < 0) {
        ss_scene_key_fault(check->report, node, "%s %s; give %s", path, why, expected);
    } else {
        ss_scene_node_fault(check->report, node, "%s %s; give %s", path, why, expected);
    }
}

static const char *kind_text(const ss_scene_node *node)
{
    if (node->kind == SS_SCENE_SCALAR) {
        return node->text[0] == '\0' && !node->is_quoted ? "has no value" : "is a single value";
    }
    return node->kind == SS_SCENE_LIST ? "is a list" : "is a mapping";
}

/* ---- values ---- */

double ss_scene_get_number(const ss_scene_node *map, const char *key, double fallback)
{
    const ss_scene_node *node = ss_scene_node_find(map, key);
    double value = 0;
    return node != NULL && node->kind == SS_SCENE_SCALAR &&
                   ss_scene_parse_number(node->text, &value) == SS_SCENE_GOOD
               ? value
               : fallback;
}

bool ss_scene_get_vector(const ss_scene_node *list, double out[3])
{
    if (list == NULL || list->kind != SS_SCENE_LIST || list->count != 3) {
        return false;
    }
    const ss_scene_node *node = list->first;
    for (int k = 0; k < 3; k++, node = node->next) {
        if (node->kind != SS_SCENE_SCALAR ||
            ss_scene_parse_number(node->text, &out[k]) != SS_SCENE_GOOD) {
            return false;
        }
    }
    return true;
}

static bool check_number(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node,
                         double *out_value)
{
    char why[96];
    if (node->kind != SS_SCENE_SCALAR) {
        fault_value(check, row, node, kind_text(node));
        return false;
    }
    if (!ss_scene_read_scalar(row, node->text, node->is_quoted, out_value, why, sizeof why)) {
        fault_value(check, row, node, why);
        return false;
    }
    return true;
}

static bool check_vector(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node,
                         double out[3])
{
    if (node->kind != SS_SCENE_LIST || node->count != 3) {
        char why[64];
        snprintf(why, sizeof why, "has %d values", (int)node->count);
        fault_value(check, row, node, node->kind == SS_SCENE_LIST ? why : kind_text(node));
        return false;
    }
    ss_scene_row each = *row;
    each.kind = SS_SCENE_NUMBER;
    bool is_good = true;
    ss_scene_node *item = node->first;
    for (int k = 0; k < 3; k++, item = item->next) {
        is_good = check_number(check, &each, item, &out[k]) && is_good;
    }
    return is_good;
}

static void check_box(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    if (node->kind != SS_SCENE_LIST || node->count != 2) {
        fault_value(check, row, node,
                    node->kind == SS_SCENE_LIST ? "does not have two corners" : kind_text(node));
        return;
    }
    double low[3], high[3];
    const bool is_low_good = check_vector(check, row, node->first, low);
    if (check_vector(check, row, node->last, high) && is_low_good &&
        (low[0] > high[0] || low[1] > high[1] || low[2] > high[2])) {
        fault_value(check, row, node, "has its corners the wrong way round");
    }
}

static void check_axes(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    if (node->kind != SS_SCENE_SCALAR) {
        fault_value(check, row, node, kind_text(node));
        return;
    }
    int seen[3] = {0, 0, 0};
    const size_t length = strlen(node->text);
    for (size_t i = 0; i < length; i++) {
        const char c = node->text[i];
        if (c < 'x' || c > 'z' || seen[c - 'x']++ > 0) {
            char why[80];
            snprintf(why, sizeof why, "is '%.40s'", node->text);
            fault_value(check, row, node, why);
            return;
        }
    }
    if (length == 0) {
        fault_value(check, row, node, "has no value");
    }
}

/* Node numbers inline; whether the mesh has them is for later. */
static void check_nodes(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    if (node->kind == SS_SCENE_SCALAR && node->text[0] != '\0') {
        node->is_path = true;
        return;
    }
    if (node->kind != SS_SCENE_LIST || node->count == 0) {
        fault_value(check, row, node,
                    node->kind == SS_SCENE_LIST ? "is an empty list" : kind_text(node));
        return;
    }
    const ss_scene_row each = {
        .name = row->name, .kind = SS_SCENE_INTEGER, .range = {.max = INT32_MAX}};
    for (ss_scene_node *item = node->first; item != NULL; item = item->next) {
        double value = 0;
        check_number(check, &each, item, &value);
    }
}

static void check_keys(ss_scene_check *check, ss_scene_node *node, ss_scene_table table);

static void check_entries(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    if (node->kind != SS_SCENE_LIST) {
        fault_value(check, row, node, kind_text(node));
        return;
    }
    if (node->count > SS_SCENE_MAX_ENTRIES) {
        char why[64];
        snprintf(why, sizeof why, "has %d entries, more than %d", (int)node->count,
                 SS_SCENE_MAX_ENTRIES);
        fault_value(check, row, node, why);
        return;
    }
    for (ss_scene_node *item = node->first; item != NULL; item = item->next) {
        if (item->kind != SS_SCENE_MAP) {
            ss_scene_row one = *row;
            one.kind = SS_SCENE_KEYS;
            fault_value(check, &one, item, kind_text(item));
            continue;
        }
        check_keys(check, item, row->child);
    }
}

/* A number, {file: NAME.csv}, or [{where: {...}, value: V}, ..., {value: rest}]. */
static void check_field(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    double value = 0;
    if (node->kind == SS_SCENE_SCALAR) {
        check_number(check, row, node, &value);
        return;
    }
    if (node->kind == SS_SCENE_MAP) {
        check_keys(check, node, ss_scene_values);
        return;
    }
    ss_scene_row entry[2] = {
        {.name = "where", .kind = SS_SCENE_KEYS, .child = ss_scene_where},
        *row,
    };
    entry[1].name = "value";
    entry[1].kind = SS_SCENE_NUMBER;
    entry[1].is_required = true;
    const ss_scene_row list = {.name = row->name, .kind = SS_SCENE_ENTRIES, .child = {entry, 2}};
    check_entries(check, &list, node);
    if (node->count == 0) {
        fault_value(check, row, node, "is an empty list");
    }
    for (ss_scene_node *item = node->first; item != NULL; item = item->next) {
        if (item->next != NULL && item->kind == SS_SCENE_MAP &&
            ss_scene_node_find(item, "where") == NULL) {
            ss_scene_node_fault(check->report, item,
                                "an entry without 'where' takes all the rest and must come last");
        }
    }
}

bool ss_scene_normalise(double v[3])
{
    /* By its largest number first, so that no square leaves the range of doubles. */
    const double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    double square = 0;
    for (int k = 0; k < 3 && largest > 0; k++) {
        v[k] /= largest;
        square += v[k] * v[k];
    }
    for (int k = 0; k < 3 && largest > 0; k++) {
        v[k] /= sqrt(square);
    }
    return largest > 0;
}

/* [x, y, z], or {file: NAME.csv}. */
static void check_direction(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    if (node->kind == SS_SCENE_MAP) {
        check_keys(check, node, ss_scene_directions);
        return;
    }
    double direction[3];
    if (check_vector(check, row, node, direction) && !ss_scene_normalise(direction)) {
        fault_value(check, row, node, "has no length");
    }
}

/* A model's row `a.b` is key b of a mapping a: rows of one mapping stand together. */
static void check_model_keys(ss_scene_check *check, ss_scene_node *node)
{
    const int32_t count = check->model_row_count;
    ss_scene_row *top = calloc((size_t)count, sizeof *top);
    ss_scene_row *below = calloc((size_t)count, sizeof *below);
    char(*name)[64] = calloc((size_t)count, sizeof *name);
    int32_t tops = 0;
    for (int32_t i = 0; top != NULL && below != NULL && name != NULL && i < count; i++) {
        const char *dot = strchr(check->model_row[i].name, '.');
        below[i] = check->model_row[i];
        if (dot == NULL) {
            top[tops++] = check->model_row[i];
            continue;
        }
        below[i].name = dot + 1;
        snprintf(name[i], sizeof name[i], "%.*s", (int)(dot - check->model_row[i].name),
                 check->model_row[i].name);
        if (tops == 0 || strcmp(top[tops - 1].name, name[i]) != 0) {
            top[tops++] =
                (ss_scene_row){.name = name[i], .kind = SS_SCENE_KEYS, .child = {.row = &below[i]}};
        }
        top[tops - 1].child.count++;
        top[tops - 1].is_required = top[tops - 1].is_required || below[i].is_required;
    }
    if (tops > 0) {
        check_keys(check, node, (ss_scene_table){top, tops});
    } else {
        ss_scene_node_fault(check->report, node, "out of memory");
    }
    SS_EACH(free, top, below, name);
}

/* The model's name picks the table for the other keys. */
static void check_model(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    if (node->kind != SS_SCENE_MAP) {
        fault_value(check, row, node, kind_text(node));
        return;
    }
    char names[TEXT_SIZE];
    ss_scene_join(ss_scene_model_name, check->models, check->model_count, names, sizeof names);
    ss_scene_node *name = ss_scene_node_find(node, "name");
    if (name == NULL) {
        ss_scene_key_fault(check->report, node, "model.name is missing; built in: %s", names);
        return;
    }
    const ss_scene_model *model = NULL;
    for (int32_t i = 0; i < check->model_count && name->kind == SS_SCENE_SCALAR; i++) {
        if (strcmp(check->models[i].name, name->text) == 0) {
            model = &check->models[i];
            check->scene->model_index = i;
            snprintf(check->scene->model_name, sizeof check->scene->model_name, "%s", model->name);
        }
    }
    if (model == NULL) {
        const char *text = name->kind == SS_SCENE_SCALAR ? name->text : "not a name";
        const char *near =
            ss_scene_nearest(text, ss_scene_model_name, check->models, check->model_count);
        ss_scene_node_fault(check->report, name,
                            "model.name is '%.40s', which is not built in; built in: %s%s%s%s",
                            text, names, near != NULL ? "; did you mean '" : "",
                            near != NULL ? near : "", near != NULL ? "'?" : "");
        return;
    }
    check->model_row = calloc((size_t)model->row_count + 1, sizeof *check->model_row);
    if (check->model_row == NULL) {
        ss_scene_node_fault(check->report, name, "out of memory");
        return;
    }
    check->model_row[0] =
        (ss_scene_row){.name = "name", .kind = SS_SCENE_TEXT, .is_required = true};
    for (int32_t i = 0; i < model->row_count; i++) {
        check->model_row[i + 1] = ss_scene_row_of_param(&model->row[i]);
    }
    check->model_row_count = model->row_count + 1;
    check_model_keys(check, node);
}

ss_scene_node *ss_scene_find_model_node(const ss_scene_node *model, const char *name)
{
    char first[64];
    const char *dot = strchr(name, '.');
    if (dot == NULL) {
        return ss_scene_node_find(model, name);
    }
    snprintf(first, sizeof first, "%.*s", (int)(dot - name), name);
    return ss_scene_node_find(ss_scene_node_find(model, first), dot + 1);
}

ss_scene_row ss_scene_row_of_param(const ss_param_row *param)
{
    static const ss_scene_kind kind[] = {
        [SS_PARAM_NUMBER] = SS_SCENE_NUMBER, [SS_PARAM_INTEGER] = SS_SCENE_INTEGER,
        [SS_PARAM_BOOL] = SS_SCENE_BOOL,     [SS_PARAM_CHOICE] = SS_SCENE_CHOICE,
        [SS_PARAM_FIELD] = SS_SCENE_FIELD,   [SS_PARAM_DIRECTION] = SS_SCENE_DIRECTION};
    if (param->kind == SS_PARAM_DIRECTION) {
        return (ss_scene_row){.name = param->name,
                              .kind = SS_SCENE_DIRECTION,
                              .range = {.min = -INFINITY, .max = INFINITY},
                              .is_required = param->is_required,
                              .fallback = NAN,
                              .help = param->help};
    }
    return (ss_scene_row){.name = param->name,
                          .kind = kind[param->kind],
                          .range = param->range,
                          .is_required = param->is_required,
                          .takes_elements = param->takes_elements,
                          .fallback = param->fallback,
                          .choices = param->choices,
                          .help = param->help,
                          .takes_links = param->takes_links,
                          .live = param->is_live ? 1 + (int32_t)SS_LIVE_MODEL_ROW : 0};
}

_Static_assert(sizeof(ss_scene_between) == sizeof(int32_t), "choices are bound as int32_t");

static void bind(ss_scene *scene, const ss_scene_row *row, const double *value)
{
    char *field = (char *)scene + row->field - 1;
    if (row->kind == SS_SCENE_INTEGER || row->kind == SS_SCENE_CHOICE) {
        const int32_t whole = (int32_t)value[0];
        memcpy(field, &whole, sizeof whole);
    } else {
        memcpy(field, value, (row->kind == SS_SCENE_VECTOR ? 3 : 1) * sizeof *value);
    }
}

static void set_table_defaults(ss_scene *scene, ss_scene_table table)
{
    for (int32_t i = 0; i < table.count; i++) {
        const ss_scene_row *row = &table.row[i];
        if (row->kind == SS_SCENE_KEYS) {
            set_table_defaults(scene, row->child);
        } else if (row->field > 0) {
            bind(scene, row, (const double[3]){row->fallback, row->fallback, row->fallback});
        }
    }
}

void ss_scene_set_defaults(ss_scene *scene)
{
    set_table_defaults(scene, ss_scene_root);
}

static void check_text(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    node->is_path = row->kind == SS_SCENE_FILE;
    if (node->kind != SS_SCENE_SCALAR || node->text[0] == '\0') {
        fault_value(check, row, node, kind_text(node));
    }
}

static void check_map(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    if (node->kind != SS_SCENE_MAP) {
        fault_value(check, row, node, kind_text(node));
    } else {
        check_keys(check, node, row->child);
    }
}

static void check_value(ss_scene_check *check, const ss_scene_row *row, ss_scene_node *node)
{
    /* Of the kinds that are no numbers. */
    static void (*const check_kind[])(ss_scene_check *, const ss_scene_row *,
                                      ss_scene_node *) = {[SS_SCENE_TEXT] = check_text,
                                                          [SS_SCENE_FILE] = check_text,
                                                          [SS_SCENE_BOX] = check_box,
                                                          [SS_SCENE_AXES] = check_axes,
                                                          [SS_SCENE_NODES] = check_nodes,
                                                          [SS_SCENE_FIELD] = check_field,
                                                          [SS_SCENE_DIRECTION] = check_direction,
                                                          [SS_SCENE_KEYS] = check_map,
                                                          [SS_SCENE_MODEL] = check_model,
                                                          [SS_SCENE_ENTRIES] = check_entries};
    const size_t kinds = sizeof check_kind / sizeof check_kind[0];
    double value[3] = {0, 0, 0};
    if ((size_t)row->kind < kinds && check_kind[row->kind] != NULL) {
        check_kind[row->kind](check, row, node);
        return;
    }
    const bool is_good = row->kind == SS_SCENE_VECTOR ? check_vector(check, row, node, value)
                                                      : check_number(check, row, node, value);
    if (is_good && row->field > 0) {
        bind(check->scene, row, value);
    }
}

/* ---- mappings ---- */

const ss_scene_row *ss_scene_find_row(ss_scene_table table, const char *name)
{
    for (int32_t i = 0; i < table.count; i++) {
        if (strcmp(table.row[i].name, name) == 0) {
            return &table.row[i];
        }
    }
    return NULL;
}

static void fault_unknown(ss_scene_check *check, ss_scene_node *node, ss_scene_table table)
{
    char path[PATH_SIZE];
    char names[TEXT_SIZE];
    if (ss_scene_report_is_full(check->report)) {
        ss_scene_key_fault(check->report, node, "unknown key");
        return;
    }
    ss_scene_node_path(node->parent, path, sizeof path);
    const char *near = ss_scene_nearest(node->key, ss_scene_row_name, table.row, table.count);
    if (near != NULL) {
        ss_scene_key_fault(check->report, node, "unknown key '%.60s' in %s; did you mean '%s'?",
                           node->key, path[0] != '\0' ? path : "the scene", near);
        return;
    }
    ss_scene_join(ss_scene_row_name, table.row, table.count, names, sizeof names);
    ss_scene_key_fault(check->report, node, "unknown key '%.60s' in %s; known here: %s", node->key,
                       path[0] != '\0' ? path : "the scene", names);
}

static const ss_scene_node *find_earlier(const ss_scene_node *node)
{
    for (const ss_scene_node *other = node->parent->first; other != node; other = other->next) {
        if (strcmp(other->key, node->key) == 0) {
            return other;
        }
    }
    return NULL;
}

/* Is one of the unknown keys of this mapping a misspelling of `name` (NULL: are there any)? Then
 * that fault is enough, and `name` is not called missing beside it. */
static bool is_misspelt(const ss_scene_node *map, ss_scene_table table, const char *name)
{
    for (const ss_scene_node *child = map->first; child != NULL; child = child->next) {
        if (ss_scene_find_row(table, child->key) != NULL) {
            continue;
        }
        if (name == NULL) {
            return true;
        }
        const char *near = ss_scene_nearest(child->key, ss_scene_row_name, table.row, table.count);
        if (near != NULL && strcmp(near, name) == 0) {
            return true;
        }
    }
    return false;
}

static void check_required(ss_scene_check *check, ss_scene_node *node, ss_scene_table table)
{
    char path[PATH_SIZE];
    char expected[TEXT_SIZE];
    ss_scene_node_path(node, path, sizeof path);
    for (int32_t i = 0; i < table.count; i++) {
        const ss_scene_row *row = &table.row[i];
        const bool is_excused =
            (row->needs != NULL && ss_scene_node_find(node, row->needs) == NULL) ||
            (row->unless != NULL && ss_scene_node_find(node, row->unless) != NULL);
        if (row->is_required && !is_excused && ss_scene_node_find(node, row->name) == NULL &&
            (ss_scene_report_is_full(check->report) || !is_misspelt(node, table, row->name))) {
            ss_scene_describe(row, expected, sizeof expected);
            ss_scene_key_fault(check->report, node, "%s%s%s is missing; give %s", path,
                               path[0] != '\0' ? "." : "", row->name, expected);
        }
    }
}

/* Keys that exclude one another: rows with the same letter. */
static void check_one_of(ss_scene_check *check, ss_scene_node *node, ss_scene_table table)
{
    char path[PATH_SIZE];
    ss_scene_node_path(node, path, sizeof path);
    for (int32_t i = 0; i < table.count; i++) {
        const char letter = table.row[i].one_of;
        bool is_first = letter != 0;
        for (int32_t j = 0; j < i; j++) {
            is_first = is_first && table.row[j].one_of != letter;
        }
        if (!is_first) {
            continue;
        }
        char names[TEXT_SIZE] = "";
        ss_scene_node *given = NULL;
        ss_scene_node *second = NULL;
        for (int32_t j = i; j < table.count; j++) {
            if (table.row[j].one_of != letter) {
                continue;
            }
            const size_t used = strlen(names);
            snprintf(names + used, sizeof names - used, "%s%s", used > 0 ? ", " : "",
                     table.row[j].name);
            ss_scene_node *found = ss_scene_node_find(node, table.row[j].name);
            second = found != NULL && given != NULL ? found : second;
            given = found != NULL && given == NULL ? found : given;
        }
        if (second != NULL) {
            ss_scene_key_fault(check->report, second->index > given->index ? second : given,
                               "%s takes one of: %s; remove '%s' or '%s'", path, names, given->key,
                               second->key);
        } else if (given == NULL && letter <= 'Z' && !is_misspelt(node, table, NULL)) {
            ss_scene_key_fault(check->report, node, "%s needs one of: %s", path, names);
        }
    }
}

static void check_keys(ss_scene_check *check, ss_scene_node *node, ss_scene_table table)
{
    for (ss_scene_node *child = node->first; child != NULL; child = child->next) {
        const ss_scene_row *row = ss_scene_find_row(table, child->key);
        const ss_scene_node *earlier = find_earlier(child);
        if (earlier != NULL) {
            char path[PATH_SIZE];
            ss_scene_node_path(child, path, sizeof path);
            ss_scene_key_fault(check->report, child,
                               "%s is given twice, first in line %lld; remove one", path,
                               (long long)ss_scene_report_line(check->report, earlier->key_offset));
        } else if (row == NULL) {
            fault_unknown(check, child, table);
        } else if (row->needs != NULL && ss_scene_node_find(node, row->needs) == NULL) {
            ss_scene_key_fault(check->report, child, "'%s' goes with '%s', which is not given",
                               row->name, row->needs);
        } else {
            check_value(check, row, child);
        }
    }
    check_required(check, node, table);
    check_one_of(check, node, table);
}

void ss_scene_check_tree(ss_scene_check *check, ss_scene_node *root)
{
    check_keys(check, root, ss_scene_root);
}
