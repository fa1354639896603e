/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "parameters.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "world/world.h"

static const double REACH = 1e4;

typedef struct chooser {
    const ss_scene *scene;
    const ss_scene_model *model;
    ss_fit_parameter *out;
    int32_t count;
    softsim_error *error;
} chooser;

static bool can_be_fitted(const ss_param_row *row)
{
    return row->kind == SS_PARAM_NUMBER || row->kind == SS_PARAM_FIELD;
}

/* The row that a path under `model.` names; NULL. */
static const ss_param_row *find_row(const chooser *c, const char *path)
{
    if (strncmp(path, "model.", 6) != 0 || strlen(path) >= SS_FIT_PATH_SIZE) {
        return NULL;
    }
    const size_t length = strcspn(path + 6, ".");
    for (int32_t i = 0; i < c->model->row_count; ++i) {
        const ss_param_row *row = &c->model->row[i];
        if (strlen(row->name) == length && strncmp(row->name, path + 6, length) == 0 &&
            can_be_fitted(row)) {
            return row;
        }
    }
    return NULL;
}

static void add(chooser *c, const char *path, const ss_param_row *row, double start)
{
    for (int32_t i = 0; i < c->count; ++i) {
        if (strcmp(c->out[i].path, path) == 0) {
            softsim_error_add(c->error, SOFTSIM_ERROR_ARGUMENT, "--parameter %s: given twice",
                              path);
            return;
        }
    }
    if (c->count == SS_FIT_MAX_PARAMETERS) {
        softsim_error_add(c->error, SOFTSIM_ERROR_ARGUMENT,
                          "--parameter %s: more than %d parameters; a curve does not tell so many",
                          path, SS_FIT_MAX_PARAMETERS);
        return;
    }
    ss_fit_parameter *to = &c->out[c->count++];
    snprintf(to->path, sizeof to->path, "%s", path);
    to->start = start;
    to->min = fmax(row->range.min, start / REACH);
    to->max = fmin(row->range.max, start * REACH);
}

/* What the model has, as one line. */
static void fault_unknown(const chooser *c, const char *path)
{
    char list[2048] = "";
    size_t used = 0;
    for (int32_t i = 0; i < c->model->row_count; ++i) {
        if (can_be_fitted(&c->model->row[i]) && used < sizeof list) {
            const int length = snprintf(list + used, sizeof list - used, "%smodel.%s",
                                        used > 0 ? ", " : "", c->model->row[i].name);
            used += length > 0 ? (size_t)length : 0;
        }
    }
    softsim_error_add(c->error, SOFTSIM_ERROR_ARGUMENT,
                      "--parameter %s: %s has no such number; it has %s", path, c->model->name,
                      list);
}

static void take_wanted(chooser *c, const char *path)
{
    char entry[SS_FIT_PATH_SIZE + 16];
    double start = NAN;
    const ss_param_row *row = find_row(c, path);
    if (!row) {
        fault_unknown(c, path);
        return;
    }
    if (!ss_scene_find_number(c->scene, c->model, path, &start)) {
        snprintf(entry, sizeof entry, "%s.0.value", path);
        const bool is_list = ss_scene_find_number(c->scene, c->model, entry, &start);
        softsim_error_add(c->error, SOFTSIM_ERROR_ARGUMENT,
                          is_list ? "--parameter %s: it varies by region; name the entries, such "
                                    "as %s.0.value"
                                  : "--parameter %s: the scene gives no number to start from; give "
                                    "one with --set %s=VALUE",
                          path, path);
        return;
    }
    if (!(start > 0.0)) {
        softsim_error_add(c->error, SOFTSIM_ERROR_ARGUMENT,
                          "--parameter %s: it starts at %g, and parameters are fitted by factors; "
                          "start above 0 with --set %s=VALUE",
                          path, start, path);
        return;
    }
    add(c, path, row, start);
}

/* One of the model's own: the number, or every entry of its region list. */
static void take_usual(chooser *c, const char *name, double absent)
{
    char path[SS_FIT_PATH_SIZE];
    double start = NAN;
    snprintf(path, sizeof path, "model.%s", name);
    const ss_param_row *row = find_row(c, path);
    if (!row) {
        return;
    }
    if (ss_scene_find_number(c->scene, c->model, path, &start)) {
        if (start > 0.0) {
            add(c, path, row, start);
        }
        return;
    }
    for (int32_t k = 0; k < SS_FIT_MAX_PARAMETERS; ++k) {
        snprintf(path, sizeof path, "model.%s.%d.value", name, k);
        if (!ss_scene_find_number(c->scene, c->model, path, &start)) {
            break;
        }
        if (start > 0.0) {
            add(c, path, row, start);
        }
        absent = 0.0;
    }
    snprintf(path, sizeof path, "model.%s", name);
    if (absent > 0.0) {
        add(c, path, row, absent);
    }
}

int32_t ss_fit_choose(const char *scene_path, const char *const *set, int32_t set_count,
                      const char *const *wanted, int32_t wanted_count, bool has_time,
                      ss_fit_parameter out[SS_FIT_MAX_PARAMETERS], softsim_error *error)
{
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t model_count = ss_world_scene_models(models);
    ss_scene *scene = NULL;
    if (ss_scene_load(scene_path, set, set_count, models, model_count, NULL, &scene, error) !=
        SOFTSIM_OK) {
        return 0;
    }
    const int32_t before = error->fault_count;
    chooser c = {.scene = scene, .model = &models[scene->model_index], .out = out, .error = error};
    for (int32_t i = 0; i < wanted_count; ++i) {
        take_wanted(&c, wanted[i]);
    }
    const ss_model_hints *hints = ss_model_find(c.model->name)->hints;
    for (const ss_hints_fitted *f = hints != NULL ? hints->fitted : NULL;
         wanted_count == 0 && f != NULL && f < hints->fitted + SS_HINTS_MAX_FITTED && f->name;
         ++f) {
        if (has_time || !f->needs_time) {
            take_usual(&c, f->name, f->start);
        }
    }
    if (error->fault_count == before && c.count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: the model %s has no parameter that is fitted by itself; name what "
                          "is to be fitted with --parameter",
                          scene_path, c.model->name);
    }
    ss_scene_destroy(&scene);
    return error->fault_count == before ? c.count : 0;
}
