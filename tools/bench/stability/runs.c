/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/stability.h"
/* The runs of the stability report: the list of them, and one of them, told in lines. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/report.h"
#include "bench/stability/audit.h"

enum { MAX_AXIS = 12, QUICK_STRIDE = 3 };

/* ---- the list ---- */

/* One kind: all stiffnesses x values x variants. */
typedef struct axes {
    ss_stress_case_kind kind;
    double stiffness[MAX_AXIS]; /* ended by 0; empty: the value is the stiffness */
    double value[MAX_AXIS];     /* ended by NAN */
    int32_t variants;
} axes;

#define END ((double)NAN)
static const axes all_axes[] = {
    {SS_STRESS_CASE_CONTROL, {1e3, 1e4, 1e5}, {0.0, END}, 3},
    {SS_STRESS_CASE_STEP,
     {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9},
     {0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0, 1.1, 1.5, 2.0, 3.0, END},
     1},
    {SS_STRESS_CASE_SUBSTEP,
     {1e2, 1e4, 1e7},
     {0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0, 1.1, 1.5, 2.0, 3.0, END},
     1},
    {SS_STRESS_CASE_STIFFNESS, {0}, {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, END}, 2},
    {SS_STRESS_CASE_POISSON,
     {1e2, 1e4, 1e7},
     {0.0, 0.3, 0.45, 0.49, 0.495, 0.499, 0.4995, 0.4999, END},
     1},
    {SS_STRESS_CASE_MASS, {1e2, 1e4, 1e7}, {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, END}, 1},
    {SS_STRESS_CASE_SLIVER, {1e2, 1e4, 1e7}, {1e0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, END}, 1},
    {SS_STRESS_CASE_TELEPORT, {1e4, 1e6}, {1e-3, 1e-2, 1e-1, 1e0, 1e1, 1e2, 1e3, 1e4, END}, 3},
    {SS_STRESS_CASE_FORCE,
     {1e2, 1e4, 1e6, 1e8},
     {1e-3, 1e-2, 1e-1, 1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, END},
     1},
    {SS_STRESS_CASE_TANGLED, {1e4}, {0.1, 0.3, 1.0, 3.0, 10.0, END}, 6},
    {SS_STRESS_CASE_FLATTENED, {1e4, 1e6}, {0.1, 0.3, 1.0, 3.0, 10.0, END}, 1},
    {SS_STRESS_CASE_FLATTENED,
     {1e4, 1e6},
     {0.5, 0.1, 0.01, 0.0, -0.5, END},
     -1}, /* variant 1 alone */
    {SS_STRESS_CASE_PROBE, {1e3, 1e4, 1e5, 1e7}, {0.1, 0.3, 1.0, 3.0, 10.0, END}, 1},
    {SS_STRESS_CASE_CONTRADICTION, {1e2, 1e4, 1e7}, {0.0, END}, SS_STRESS_CASE_CONTRADICTIONS},
    {SS_STRESS_CASE_NOISE, {1e3, 1e4, 1e5}, {1e-4, 3e-4, 1e-3, 3e-3, END}, 1},
    {SS_STRESS_CASE_IN_OUT, {1e3, 1e4, 1e5}, {50.0, 125.0, 250.0, 500.0, END}, 1},
    {SS_STRESS_CASE_THROUGH, {1e3, 1e4, 1e5}, {1.0, 10.0, 100.0, END}, 3},
    {SS_STRESS_CASE_SPIN, {1e3, 1e4, 1e5}, {1.0, 10.0, 100.0, 499.0, END}, 2},
    {SS_STRESS_CASE_PAUSE, {1e3, 1e4, 1e5}, {100.0, 1000.0, 2000.0, END}, 1},
};

/* Quick: the first, the last and every third between. */
static bool is_taken(bool is_quick, int32_t index, bool is_last)
{
    return !is_quick || is_last || index % QUICK_STRIDE == 0;
}

/* Adds a run, or counts it while there is no list. */
static void add_run(ss_stability *list, const ss_stress_case *trial)
{
    if (list->trial != NULL) {
        list->trial[list->count] = *trial;
    }
    ++list->count;
}

static void add_values(ss_stability *list, int32_t subject, const axes *a, double stiffness,
                       bool is_quick)
{
    const int32_t first = a->variants < 0 ? -a->variants : 0;
    const int32_t end = a->variants < 0 ? first + 1 : a->variants;
    for (int32_t v = 0; !isnan(a->value[v]); ++v) {
        if (!is_taken(is_quick, v, isnan(a->value[v + 1]))) {
            continue;
        }
        for (int32_t w = first; w < end; ++w) {
            const ss_stress_case trial = {.subject = subject,
                                          .kind = a->kind,
                                          .stiffness_pa = stiffness > 0.0 ? stiffness : a->value[v],
                                          .value = a->value[v],
                                          .variant = w};
            add_run(list, &trial);
        }
    }
}

static void add_runs(ss_stability *list, int32_t subject, bool is_quick)
{
    for (size_t k = 0; k < sizeof all_axes / sizeof *all_axes; ++k) {
        const axes *a = &all_axes[k];
        if (!ss_stress_case_applies(subject, a->kind)) {
            continue;
        }
        if (a->stiffness[0] == 0.0) {
            add_values(list, subject, a, 0.0, is_quick);
        }
        for (int32_t e = 0; a->stiffness[e] > 0.0; ++e) {
            const bool is_wide = a->kind != SS_STRESS_CASE_STEP;
            /* The quick report has one stiffness of few, and every third of many. */
            if (!is_quick || (is_wide ? a->stiffness[e] == 1e4 : is_taken(true, e, false))) {
                add_values(list, subject, a, a->stiffness[e], is_quick);
            }
        }
    }
}

static void add_subjects(ss_stability *list, const char *const *only, bool is_quick)
{
    list->count = 0;
    for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
        bool is_wanted = only[0] == NULL;
        for (const char *const *name = only; *name != NULL; ++name) {
            is_wanted = is_wanted || strcmp(*name, ss_stress_case_subject_model(s)) == 0;
        }
        if (is_wanted) {
            add_runs(list, s, is_quick);
        }
    }
}

bool ss_stability_list(ss_stability *list, const char *const *only, bool is_quick)
{
    *list = (ss_stability){.trial = NULL};
    add_subjects(list, only, is_quick);
    list->trial = calloc((size_t)list->count + 1, sizeof *list->trial);
    if (list->trial == NULL) {
        return false;
    }
    add_subjects(list, only, is_quick);
    return true;
}

void ss_stability_list_fini(ss_stability *list)
{
    free(list->trial);
    list->trial = NULL;
}

void ss_stability_label(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE])
{
    const ss_stability *list = context;
    const ss_stress_case *trial = &list->trial[index];
    snprintf(out, SS_SWEEP_NAME_SIZE, "%s,%s,%.9g,%.9g,%d",
             ss_stress_case_subject_name(trial->subject), ss_stress_case_kind_name(trial->kind),
             trial->stiffness_pa, trial->value, trial->variant);
}

/* ---- one run: a line for us, what acted, a line of the CSV ---- */

static void put_number(FILE *file, double value)
{
    if (isnan(value)) {
        fputc(',', file);
    } else {
        fprintf(file, ",%.6g", value);
    }
}

softsim_status ss_stability_run(const void *context, int32_t index, FILE *out, softsim_error *error)
{
    const ss_stability *list = context;
    ss_stress_case_result r;
    char label[SS_SWEEP_NAME_SIZE], found[192];
    const softsim_status status = ss_stress_case_run(&list->trial[index], list->scratch, &r, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const bool is_refused = r.outcome == SS_STRESS_CASE_REFUSED;
    fprintf(out, "%d %d %u %d %d\n%s\n", (int)r.outcome, (int)r.verdict, r.found, r.is_agreed,
            r.inverted, r.acted);
    ss_stability_label(context, index, label);
    ss_audit_text(r.found, found, (int32_t)sizeof found);
    fprintf(out, "%s,%s,%s,", label, ss_stress_case_outcome_name(r.outcome),
            is_refused ? "" : softsim_verdict_name(r.verdict));
    ss_csv_text(out, r.acted);
    fputc(',', out);
    ss_csv_text(out, found);
    fprintf(out, ",%s", r.is_agreed ? "yes" : "no");
    put_number(out, r.limit_s);
    put_number(out, r.step_s);
    fprintf(out, ",%d", r.ticks);
    const double values[] = {r.substeps,     r.stored_j,       r.end_j,    r.balance,
                             r.work_error,   r.displacement_m, r.recovery, r.kinetic_j,
                             r.handed_out_j, r.made_j,         r.driven_j, r.force_n,
                             r.depth_m};
    for (size_t k = 0; k < sizeof values / sizeof *values; ++k) {
        put_number(out, values[k]);
    }
    fprintf(out, ",%d", r.inverted);
    put_number(out, r.cpu_ms);
    fputc('\n', out);
    return SOFTSIM_OK;
}

void ss_stability_read(const ss_sweep_result *result, int32_t index, ss_stability_row *out)
{
    const ss_sweep_run *run = &result->run[index];
    int outcome = 0, verdict = 0, agreed = 0, used = 0;
    *out = (ss_stability_row){.is_lost = true, .outcome = SS_STRESS_CASE_DIVERGED};
    if (!run->is_lost && sscanf(run->text, "%d %d %u %d %d%n", &outcome, &verdict, &out->found,
                                &agreed, &out->inverted, &used) == 5) {
        const char *acted = run->text + used + 1; /* may be an empty line */
        const int length = (int)strcspn(acted, "\n");
        out->is_lost = false;
        out->is_agreed = agreed != 0;
        out->outcome = (ss_stress_case_outcome)outcome;
        out->verdict = (softsim_verdict)verdict;
        snprintf(out->acted, sizeof out->acted, "%.*s", length, acted);
        out->csv = acted + length + 1;
    } else {
        snprintf(out->acted, sizeof out->acted, "%.*s", (int)sizeof out->acted - 1, run->text);
    }
}
