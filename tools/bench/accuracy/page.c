/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The page of softsim-bench accuracy, and the table of dynamic cases. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/accuracy/report.h"
#include "output.h"

enum { ROW_CELLS = 11 };

/* ---- the page ---- */

softsim_status ss_accuracy_write_dynamics(ss_accuracy *r, softsim_error *error)
{
    ss_output output;
    const softsim_status status = ss_report_csv_open(
        &output, r->o.out, "dynamics",
        "case,model,mesh,f1_error,first_minimum_error,rms_first_period,verdict", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs(r->dynamics != NULL ? r->dynamics : "", output.file);
    return ss_output_commit(&output, error);
}

static void put_means(const ss_accuracy_means *means, ss_page *page)
{
    static const char *const head[ROW_CELLS] = {
        "model",       "mesh",      "nodes",           "field error",
        "force error", "us a step", "times real time", "ms to within 1 %",
        "calibrated",  "front",     "verdict"};
    for (int32_t k = 0; k < means->count; ++k) {
        means->time[k] = 1.0 / means->mean[k].realtime;
        means->error[k] = means->mean[k].is_other ? (double)NAN : means->mean[k].error_l2;
    }
    ss_accuracy_pareto(means->count, means->time, means->error, means->is_front);
    ss_page_table_begin(page, ROW_CELLS, head);
    for (int32_t k = 0; k < means->count; ++k) {
        const ss_accuracy_mean *m = &means->mean[k];
        ss_row cells = {.count = 0};
        ss_row_add(&cells, "%s%s", m->first->model, m->first->source > 0 ? " *" : "");
        ss_row_add(&cells, "%s", m->first->mesh);
        ss_row_add(&cells, "%d", m->first->nodes);
        ss_row_add_number(&cells, m->error_l2);
        ss_row_add_number(&cells, m->error_force);
        ss_row_add_number(&cells, m->p50_us);
        ss_row_add_number(&cells, m->realtime);
        ss_row_add_number(&cells, m->to_1pct_ms);
        ss_row_add(&cells, "%s", m->is_calibrated ? "yes" : "");
        ss_row_add(&cells, "%s", means->is_front[k] ? "*" : "");
        ss_row_add(&cells, "%s", strcmp(m->verdict, "good") != 0 ? m->verdict : "");
        ss_page_table_row(page, cells.count, cells.cell);
    }
    ss_page_table_end(page);
}

static char *read_snippet(const ss_accuracy *r, const ss_accuracy_mean *m)
{
    char path[SS_ACCURACY_PATH + 400];
    softsim_error missing = {.status = SOFTSIM_OK};
    size_t size = 0;
    snprintf(path, sizeof path, "%s/scenes/%s_%s_%s_%s.yaml", r->o.out, m->first->case_name,
             m->first->material, m->first->model, m->first->mesh);
    return m->first->source == 0 ? ss_table_read_file(path, &size, &missing) : NULL;
}

/* The best choice within the budget, onto the page and the terminal. */
static void put_budget(const ss_accuracy *r, ss_page *page, const char *case_name,
                       const char *material, const ss_accuracy_means *means)
{
    if (r->o.budget_us <= 0.0) {
        return;
    }
    const ss_accuracy_mean *best = ss_accuracy_choose(means->mean, means->count, r->o.budget_us);
    char text[600], force[64] = "";
    if (best == NULL) {
        snprintf(text, sizeof text, "%s, %s: no model takes %g us a step or less", case_name,
                 material, r->o.budget_us);
    } else {
        if (!isnan(best->error_force)) {
            snprintf(force, sizeof force, ", force error %.3g", best->error_force);
        }
        snprintf(
            text, sizeof text,
            "%s, %s, %g us: %s on mesh %s (%d nodes): field error %.3g%s%s, %.4g us a step, %.3g "
            "times real time%s",
            case_name, material, r->o.budget_us, best->first->model, best->first->mesh,
            best->first->nodes, best->error_l2, force,
            best->is_calibrated ? " (fitted on the first of these levels)" : "", best->p50_us,
            best->realtime, best->realtime < 1.0 ? " (slower: not for the hand)" : "");
    }
    char *snippet = best != NULL ? read_snippet(r, best) : NULL;
    printf("%s\n%s", text, snippet != NULL ? snippet : "");
    ss_page_text(page, "%s", text);
    if (snippet != NULL) {
        ss_page_code(page, snippet);
    }
    free(snippet);
}

static bool has_rows(const ss_case *c, int32_t material, const ss_accuracy_rows *rows)
{
    for (int32_t i = 0; i < rows->count; ++i) {
        if (strcmp(rows->row[i].case_name, c->name) == 0 &&
            strcmp(rows->row[i].material, c->material[material]) == 0) {
            return true;
        }
    }
    return false;
}

static softsim_status put_case(const ss_accuracy *r, ss_page *page, const ss_case *c,
                               softsim_error *error)
{
    softsim_status status = SOFTSIM_OK;
    int32_t shaped = -1; /* nh where there is one: it goes furthest */
    for (int32_t m = 0; m < c->material_count; ++m) {
        if (has_rows(c, m, &r->rows) && (shaped < 0 || strcmp(c->material[shaped], "nh") != 0)) {
            shaped = m;
        }
    }
    for (int32_t m = 0; m < c->material_count && status == SOFTSIM_OK; ++m) {
        char title[128];
        if (!has_rows(c, m, &r->rows)) {
            continue;
        }
        snprintf(title, sizeof title, "%s, %s", c->name, c->material[m]);
        ss_page_heading(page, title);
        ss_accuracy_means means;
        status = ss_accuracy_means_find(&r->rows, c->name, c->material[m], &means, error);
        if (status == SOFTSIM_OK) {
            put_budget(r, page, c->name, c->material[m], &means);
            put_means(&means, page);
        }
        ss_accuracy_means_fini(&means);
        status = status != SOFTSIM_OK
                     ? status
                     : ss_accuracy_draw(page, &r->plan, c, m, m == shaped, &r->rows, error);
    }
    return status;
}

static void put_dynamics(const ss_accuracy *r, ss_page *page)
{
    static const char *const head[] = {
        "case",   "model", "mesh", "first frequency", "first minimum", "rms of the first period",
        "verdict"};
    ss_page_heading(page, "Motion");
    ss_page_text(page, "Gravity switched on, undamped: errors as fractions, the worst of the "
                       "steps.");
    ss_page_table_begin(page, 7, head);
    char *copy = strdup(r->dynamics);
    for (char *at = copy, *line = NULL; copy != NULL && (line = strsep(&at, "\n")) != NULL;) {
        ss_row cells = {.count = 0};
        for (int k = 0; k < 6 && line != NULL && *line != '\0'; ++k) {
            ss_row_add(&cells, "%s", strsep(&line, ","));
        }
        if (cells.count == 6) {
            /* The rest, which may have commas and then is quoted. */
            const char *verdict = line != NULL ? line + (*line == '"') : "";
            const size_t length = strlen(verdict);
            const bool is_quoted = length > 0 && verdict[length - 1] == '"';
            ss_row_add(&cells, "%.*s", (int)(length - is_quoted), verdict);
            ss_page_table_row(page, cells.count, cells.cell);
        }
    }
    free(copy);
    ss_page_table_end(page);
}

static void put_places(const ss_accuracy *r, ss_page *page)
{
    int32_t count = 0;
    const ss_model_class *const *table = ss_model_table(&count);
    ss_page_heading(page, "What each model is for");
    for (int32_t i = 0; i < count; ++i) {
        const ss_model_class *model = ss_accuracy_model_find(table[i]->name);
        if (model != NULL && ss_accuracy_is_listed(r->o.model, model->name)) {
            ss_page_text(page, "%s: %s.", model->name, model->hints->about);
        }
    }
}

softsim_status ss_accuracy_write_page(ss_accuracy *r, softsim_error *error)
{
    ss_page page;
    softsim_status status =
        ss_page_open(&page, r->o.out, "accuracy", "softsim: error against run time", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(
        &page,
        "Every model on problems with trusted solutions, through the scene loader and the "
        "world of the server, without LCM, in steps of 1 ms on one thread. Errors are "
        "fractions: of the field sqrt(sum w |u - u_ref|^2 / sum w |u_ref|^2), of the "
        "force |F - F_ref| / |F_ref| along the push; times are thread CPU time. Loads "
        "come over a ramp, and the body is damped until it has settled. Tables hold means "
        "over a material's levels. A verdict is the program's own, on how a run went: 'good' "
        "is stable, not near; where half of the field or more is wrong it says so.");
    ss_page_text(&page, "Calibrated: what a model leaves free was fitted on the first level of "
                        "each material and mesh, the field first, then the force; its other levels "
                        "are predictions, its first is not.");
    for (int32_t i = 0; i < r->o.set.count; ++i) {
        ss_page_text(&page, "Set, for models that have it: %s", r->o.set.value[i]);
    }
    if (r->o.scene != NULL) {
        printf("%s\n", r->worth.text);
        ss_page_text(&page, "%s: %s", r->o.scene, r->worth.taken);
        ss_page_text(&page, "%s: %s", r->o.scene, r->worth.text);
    }
    ss_page_link(&page, "accuracy.csv");
    put_places(r, &page);
    for (int32_t k = 0; k < r->plan.case_count && status == SOFTSIM_OK; ++k) {
        status = put_case(r, &page, &r->plan.c[k], error);
    }
    if (r->dynamic.job_count > 0) {
        put_dynamics(r, &page);
        ss_page_link(&page, "dynamics.csv");
    }
    for (int32_t k = 1; k <= r->rows.source_count; ++k) {
        ss_page_text(&page, "*: from %s.", r->rows.source[k]);
    }
    ss_page_yardstick(&page, &r->yardstick);
    if (status == SOFTSIM_OK) {
        return ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}
