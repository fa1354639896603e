/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Are the bodies of the accuracy report whole? Every file that a job will read is read once before
 * the first job starts, one body at a time, and dropped: on the largest bundled mesh that is a
 * tenth of a second, where a damaged file found by its job costs the hours of those before it.
 * Rejected: keeping what was read for the jobs, which are processes of their own, perhaps on other
 * machines. The rows of other programs (--compare) are judged here too: a picture that lacks some
 * of them, or shows them as what they are not, says nothing about them.
 */
#include <math.h>
#include <string.h>

#include "bench/accuracy/accuracy.h"
#include "models/model.h"

/* What a job reads: two with the same need it once. */
typedef struct need {
    int32_t case_index, material, mesh;
    bool on_surface;
} need;

static need need_of(const ss_accuracy_job *job)
{
    const ss_model_class *model = ss_accuracy_model_find(job->model);
    return (need){.case_index = job->case_index,
                  .material = job->material,
                  .mesh = job->mesh,
                  .on_surface = model != NULL && model->hints->on_surface};
}

/* Does an earlier job read the same? */
static bool is_known(const ss_accuracy_plan *plan, int32_t index)
{
    const need own = need_of(&plan->job[index]);
    for (int32_t k = 0; k < index; ++k) {
        const need other = need_of(&plan->job[k]);
        if (other.case_index == own.case_index && other.material == own.material &&
            other.mesh == own.mesh && other.on_surface == own.on_surface) {
            return true;
        }
    }
    return false;
}

/* Bodies share files: what one says of a file is not said again for the next. */
static void take_faults(const softsim_error *own, softsim_error *error)
{
    if (own->fault_count > 0 && strstr(error->text, own->text) == NULL) {
        softsim_error_append(error, own->status, own->text);
    }
}

static void check_plan(const ss_accuracy_plan *plan, softsim_error *error)
{
    for (int32_t k = 0; k < plan->job_count; ++k) {
        if (is_known(plan, k)) {
            continue;
        }
        const need own = need_of(&plan->job[k]);
        const ss_case *c = &plan->c[own.case_index];
        int32_t count = 0;
        ss_case_body body;
        softsim_error faults = {.status = SOFTSIM_OK};
        const ss_case_mesh *mesh = &ss_case_meshes(c, own.on_surface, &count)[own.mesh];
        ss_case_load_body(c, mesh, own.material, own.on_surface, &body, &faults);
        ss_case_body_fini(&body);
        take_faults(&faults, error);
    }
}

softsim_status ss_accuracy_check_bodies(const ss_accuracy_plan *plan,
                                        const ss_accuracy_plan *dynamic, softsim_error *error)
{
    const int32_t faults = error->fault_count;
    check_plan(plan, error);
    check_plan(dynamic, error);
    return error->fault_count > faults ? error->status : SOFTSIM_OK;
}

/* ---- rows of other programs ---- */

enum { MAX_BAD_ROWS = 10 }; /* then the file is something else */

static bool starts_as(const char *text, const char *word)
{
    const size_t length = strlen(word);
    return strncmp(text, word, length) == 0 && strchr(":; ", text[length]) != NULL;
}

/* "good", "degraded: why", "refused; why"; empty: the program has none. */
static bool is_verdict(const char *text)
{
    bool is_known = text[0] == '\0' || starts_as(text, "diverged") || starts_as(text, "refused");
    for (int k = 0; k <= SOFTSIM_VERDICT_FAULT; ++k) {
        is_known = is_known || starts_as(text, softsim_verdict_name((softsim_verdict)k));
    }
    return is_known;
}

static const ss_case *find_case(const ss_accuracy_plan *plan, const char *name)
{
    for (int32_t k = 0; k < plan->case_count; ++k) {
        if (strcmp(plan->c[k].name, name) == 0) {
            return &plan->c[k];
        }
    }
    return NULL;
}

static bool has_level(const ss_case *c, const ss_accuracy_row *row)
{
    for (int32_t k = 0; k < c->level_count; ++k) {
        if (strcmp(c->level[k].tag, row->level) == 0 &&
            strcmp(c->material[c->level[k].material], row->material) == 0) {
            return true;
        }
    }
    return false;
}

/* The first number that cannot be: NULL when all can. Empty cells are NaN. */
static const char *find_bad_number(const ss_accuracy_row *row)
{
    const struct {
        const char *name;
        double value;
        bool is_positive;
    } number[] = {
        {"error_l2", row->error_l2, false},       {"error_max", row->error_max, false},
        {"error_force", row->error_force, false}, {"us_per_step_p50", row->p50_us, true},
        {"us_per_step_p99", row->p99_us, true},   {"dt_s", row->dt_s, true},
        {"realtime_factor", row->realtime, true}, {"time_to_1pct_ms", row->to_1pct_ms, false}};
    for (size_t k = 0; k < sizeof number / sizeof *number; ++k) {
        const double value = number[k].value;
        if (isinf(value) || value < 0.0 || (number[k].is_positive && value <= 0.0)) {
            return number[k].name;
        }
    }
    return NULL;
}

/* What is wrong with a row and what to do, into `out`; false: nothing. */
static bool find_fault(const ss_accuracy_plan *plan, const ss_accuracy_row *row, char out[512])
{
    const ss_case *c = find_case(plan, row->case_name);
    const char *bad = find_bad_number(row);
    if (c == NULL) {
        snprintf(out, 512,
                 "case '%s' is not among this report's; give its --case too, or leave the row out",
                 row->case_name);
    } else if (!has_level(c, row)) {
        snprintf(out, 512,
                 "case '%s' has no level '%s' of a material '%s'; give those of its case.yaml",
                 row->case_name, row->level, row->material);
    } else if (row->model[0] == '\0') {
        snprintf(out, 512, "model is empty; give the other program's name");
    } else if (ss_model_find(row->model) != NULL) {
        snprintf(out, 512, "model '%s' is one of this program's own; give the other program's name",
                 row->model);
    } else if (bad != NULL) {
        snprintf(out, 512,
                 "%s: errors are not below 0, times and factors above it and finite; leave a cell "
                 "empty that is not known",
                 bad);
    } else if (strcmp(row->calibrated, "yes") != 0 && strcmp(row->calibrated, "no") != 0 &&
               row->calibrated[0] != '\0') {
        snprintf(out, 512, "calibrated is '%s'; give yes or no", row->calibrated);
    } else if (!is_verdict(row->verdict)) {
        snprintf(out, 512,
                 "verdict '%.60s' is not one of good, guarded, degraded, fault, diverged, refused; "
                 "begin with one of these and a colon, or leave it empty",
                 row->verdict);
    } else {
        return false;
    }
    return true;
}

void ss_accuracy_check_compared(const ss_accuracy_plan *plan, const ss_accuracy_rows *rows,
                                softsim_error *error)
{
    int32_t bad = 0;
    for (int32_t i = 0; i < rows->count && bad < MAX_BAD_ROWS; ++i) {
        const ss_accuracy_row *row = &rows->row[i];
        char text[512];
        if (find_fault(plan, row, text)) {
            softsim_error_add(error, SOFTSIM_ERROR_FORMAT, "%s:%d: %s", rows->source[row->source],
                              row->line, text);
            ++bad;
        }
    }
}
