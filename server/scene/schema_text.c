/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* One row of a table in words, and one scalar by its row: what may stand there, what was meant. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/schema.h"

enum { LONGEST_NAME = 40 };

int32_t ss_scene_choice(const char *choices, const char *text)
{
    const size_t length = strlen(text);
    int32_t index = 0;
    for (const char *at = choices; length > 0; index++) {
        const size_t word = strcspn(at, "|");
        if (word == length && memcmp(at, text, length) == 0) {
            return index;
        }
        if (at[word] == '\0') {
            break;
        }
        at += word + 1;
    }
    return -1;
}

void ss_scene_choice_name(const char *choices, int32_t index, char *out, size_t size)
{
    const char *at = choices;
    for (; index > 0 && strchr(at, '|') != NULL; index--) {
        at = strchr(at, '|') + 1;
    }
    snprintf(out, size, "%.*s", (int)strcspn(at, "|"), at);
}

/* Edits (insert, remove, change a letter) from a to b, neither longer than LONGEST_NAME. */
static int distance(const char *a, const char *b)
{
    const size_t n = strlen(a);
    const size_t m = strlen(b);
    int row[LONGEST_NAME + 1];
    for (size_t j = 0; j <= m; j++) {
        row[j] = (int)j;
    }
    for (size_t i = 1; i <= n; i++) {
        int diagonal = row[0];
        row[0] = (int)i;
        for (size_t j = 1; j <= m; j++) {
            const int change =
                diagonal + (tolower((unsigned char)a[i - 1]) != tolower((unsigned char)b[j - 1]));
            diagonal = row[j];
            const int shift = 1 + (row[j] < row[j - 1] ? row[j] : row[j - 1]);
            row[j] = change < shift ? change : shift;
        }
    }
    return row[m];
}

const char *ss_scene_nearest(const char *name, const char *(*name_at)(const void *list, int32_t i),
                             const void *list, int32_t count)
{
    const size_t length = strlen(name);
    const char *best = NULL;
    int best_distance = length < 6 ? 2 : 1 + (int)length / 3;
    for (int32_t i = 0; i < count; i++) {
        const char *other = name_at(list, i);
        const size_t longer = length > strlen(other) ? length : strlen(other);
        int d = longer > LONGEST_NAME ? 99 : distance(name, other);
        /* A name with its unit forgotten, or with one too many. */
        const size_t common = strlen(other) < length ? strlen(other) : length;
        if (common >= 3 && d > 1 && strncmp(name, other, common) == 0) {
            d = 1;
        }
        if (d < best_distance) {
            best = other;
            best_distance = d;
        }
    }
    return best;
}

const char *ss_scene_row_name(const void *list, int32_t i)
{
    return ((const ss_scene_row *)list)[i].name;
}

const char *ss_scene_model_name(const void *list, int32_t i)
{
    return ((const ss_scene_model *)list)[i].name;
}

void ss_scene_join(const char *(*name_at)(const void *list, int32_t i), const void *list,
                   int32_t count, char *out, size_t size)
{
    size_t used = 0;
    out[0] = '\0';
    for (int32_t i = 0; i < count && used < size; i++) {
        const int written =
            snprintf(out + used, size - used, "%s%s", i > 0 ? ", " : "", name_at(list, i));
        used += written > 0 ? (size_t)written : 0;
    }
}

static void describe_range(const ss_scene_row *row, char *out, size_t size)
{
    const ss_range *range = &row->range;
    char low[48] = "";
    char high[48] = "";
    if (isfinite(range->min)) {
        const char *word = range->exclusive_min   ? "above"
                           : isfinite(range->max) ? "from"
                                                  : "of at least";
        snprintf(low, sizeof low, " %s %.10g", word, range->min);
    }
    if (isfinite(range->max)) {
        const char *word = low[0] == '\0'         ? "of at most"
                           : range->exclusive_min ? "and at most"
                                                  : "to";
        snprintf(high, sizeof high, " %s %.10g", word, range->max);
    }
    if (range->min == range->max && !range->exclusive_min) {
        snprintf(low, sizeof low, " %.10g", range->min);
        high[0] = '\0';
    }
    snprintf(out, size, "%s%s%s%s%s", low, high, row->unit != NULL ? " (" : "",
             row->unit != NULL ? row->unit : "", row->unit != NULL ? ")" : "");
}

void ss_scene_describe(const ss_scene_row *row, char *out, size_t size)
{
    /* Each followed by `what` of it, then by `after`. */
    enum { NOTHING, RANGE, CHOICES, HELP, NAMES };
    static const struct {
        const char *before, *after;
        int what;
    } kinds[] = {
        [SS_SCENE_NUMBER] = {"a number", "", RANGE},
        [SS_SCENE_INTEGER] = {"a whole number", "", RANGE},
        [SS_SCENE_RATE] = {"auto, or a number", "", RANGE},
        [SS_SCENE_BOOL] = {"true or false", "", NOTHING},
        [SS_SCENE_CHOICE] = {"one of ", "", CHOICES},
        [SS_SCENE_TEXT] = {"a name: ", "", HELP},
        [SS_SCENE_FILE] = {"the name of a file: ", "", HELP},
        [SS_SCENE_VECTOR] = {"[x, y, z], each a number", "", RANGE},
        [SS_SCENE_BOX] = {"[[x, y, z], [x, y, z]], lower corner first, each a number", "", RANGE},
        [SS_SCENE_AXES] = {"axes of the world, such as xyz, xy or z", "", NOTHING},
        [SS_SCENE_NODES] = {"[0, 1, 2], or the name of a file with one number a line", "", NOTHING},
        [SS_SCENE_FIELD] = {"a number",
                            ", {file: NAME.csv}, or a list of {where: ..., value: ...}, of "
                            "which the first that matches counts",
                            RANGE},
        [SS_SCENE_DIRECTION] = {"[x, y, z] of any length but 0, or {file: NAME.csv}", "", NOTHING},
        [SS_SCENE_KEYS] = {"a mapping with keys of: ", "", NAMES},
        [SS_SCENE_MODEL] = {"a mapping with the key name and the model's parameters", "", NOTHING},
        [SS_SCENE_ENTRIES] = {"a list of mappings with keys of: ", "", NAMES},
    };
    char range[128], names[160];
    describe_range(row, range, sizeof range);
    ss_scene_join(ss_scene_row_name, row->child.row, row->child.count, names, sizeof names);
    const char *of[] = {[NOTHING] = "",
                        [RANGE] = range,
                        [CHOICES] = row->choices,
                        [HELP] = row->help,
                        [NAMES] = names};
    snprintf(out, size, "%s%s%s", kinds[row->kind].before, of[kinds[row->kind].what],
             kinds[row->kind].after);
    for (char *bar = out; row->kind == SS_SCENE_CHOICE && (bar = strchr(bar, '|')) != NULL;) {
        *bar = ' ';
    }
}

/* ---- scalars ---- */

bool ss_scene_read_scalar(const ss_scene_row *row, const char *text, bool is_quoted,
                          double *out_value, char *why, size_t why_size)
{
    double value = 0;
    if (text[0] == '\0' && !is_quoted) {
        snprintf(why, why_size, "has no value");
        return false;
    }
    if (row->kind == SS_SCENE_BOOL || row->kind == SS_SCENE_CHOICE) {
        const char *words = row->kind == SS_SCENE_BOOL ? "false|true" : row->choices;
        const int32_t index = ss_scene_choice(words, text);
        snprintf(why, why_size, "is '%.40s'", text);
        *out_value = index;
        return index >= 0;
    }
    if (row->kind == SS_SCENE_RATE && strcmp(text, "auto") == 0) {
        *out_value = 0;
        return true;
    }
    const ss_scene_number kind = ss_scene_parse_number(text, &value);
    if (kind == SS_SCENE_NOT_FINITE) {
        snprintf(why, why_size, "is '%.40s', which is not finite", text);
        return false;
    }
    if (kind == SS_SCENE_NOT_NUMBER || is_quoted) {
        snprintf(why, why_size, "is '%.40s', which is %s", text,
                 is_quoted ? "a text in quotes" : "not a number");
        return false;
    }
    if (row->kind == SS_SCENE_INTEGER && value != floor(value)) {
        snprintf(why, why_size, "is %.40s, which is not a whole number", text);
        return false;
    }
    if (!ss_in_range(&row->range, value)) {
        snprintf(why, why_size, "is %.40s, out of range", text);
        return false;
    }
    *out_value = value;
    return true;
}
