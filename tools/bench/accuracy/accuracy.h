/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the files of softsim-bench accuracy share: the list of jobs, the rows they leave, the page.
 *
 * A job is a case, a material, a model and a mesh: it fits what is free on the first level, runs
 * all levels and leaves a row each. Beside the rows it leaves files in the report's folder, named
 * after it: fields/ID.csv, the field of the last level beside the reference, and scenes/ID.yaml,
 * the lines of a scene that describe the model as it was run. Jobs are runs of a sweep
 * (core/sweep.h). Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "bench/accuracy/models.h"
#include "bench/core/report.h"
#include "case/case.h"
#include "case/table.h"

enum { SS_ACCURACY_MAX_CASES = 64, SS_ACCURACY_PATH = 1024, SS_ACCURACY_MAX_SOURCES = 16 };
enum { SS_ACCURACY_SCRATCH = 32 };

typedef struct ss_accuracy_job {
    int32_t case_index, material, mesh; /* mesh: of ss_case_meshes(case, model's on_surface) */
    const char *model;
} ss_accuracy_job;

typedef struct ss_accuracy_plan {
    const char *folder;
    ss_case *c;
    int32_t case_count;
    uint64_t digest[SS_ACCURACY_MAX_CASES]; /* of each case's files */
    ss_accuracy_job *job;
    int32_t job_count;
    bool is_quick;          /* of a material the first and the last level */
    const ss_arg_list *set; /* as ss_hints_setting has it */
    double longest_cpu_s;   /* of a level */
} ss_accuracy_plan;

/* case_material_model_mesh, as files are called. */
void ss_accuracy_job_id(const ss_accuracy_plan *plan, int32_t index, char out[256]);
/* What the temporary folders of the jobs are called that process `owner` has started. */
void ss_accuracy_scratch_name(int64_t owner, char out[SS_ACCURACY_SCRATCH]);
/* Runs a job: one line a level (ss_accuracy_line) into `out`. Loads that a model cannot take are
 * rows; an error is a body that cannot be read, or a lack of memory or disk. */
softsim_status ss_accuracy_run_job(const void *plan, int32_t index, FILE *out,
                                   softsim_error *error);
/* The same for dynamic cases, whose jobs have material -1: one line of dynamics.csv. */
softsim_status ss_accuracy_run_dynamic(const void *plan, int32_t index, FILE *out,
                                       softsim_error *error);
/* Reads every file that the jobs of both plans will read, each body once: a damaged one is a fault
 * here, before any run has begun. */
softsim_status ss_accuracy_check_bodies(const ss_accuracy_plan *plan,
                                        const ss_accuracy_plan *dynamic, softsim_error *error);
/* The rows of a job that was lost: all its levels, with the reason. */
void ss_accuracy_lose_job(const ss_accuracy_plan *plan, int32_t index, const char *reason,
                          FILE *out);

/* ---- rows ---- */

typedef struct ss_accuracy_row {
    char case_name[64], material[32], model[64], mesh[32], level[32], calibrated[8], verdict[400];
    int32_t nodes, elements;
    double error_l2, error_max, error_force; /* NaN: does not exist */
    double p50_us, p99_us, dt_s, realtime, to_1pct_ms;
    double value, force; /* of the level, and of the tool along the push; NaN in files of others */
    int32_t source;      /* 0: this run; else the file of others, from 1 */
    int32_t line;        /* of that file */
} ss_accuracy_row;

typedef struct ss_accuracy_rows {
    ss_accuracy_row *row;
    int32_t count;
    const char *source[SS_ACCURACY_MAX_SOURCES]; /* from 1 */
    int32_t source_count;
} ss_accuracy_rows;

/* The head of accuracy.csv. */
extern const char ss_accuracy_head[];
/* A row of accuracy.csv; with `is_whole` two further cells, value and force. */
void ss_accuracy_line(FILE *file, const ss_accuracy_row *row, bool is_whole);
/* A comma and a number, or nothing for NaN. */
void ss_accuracy_put(FILE *file, double value);
/* Adds the rows of what jobs have left; takes the text. */
softsim_status ss_accuracy_rows_add(ss_accuracy_rows *rows, char *text, softsim_error *error);
/* Adds a file with the columns of accuracy.csv. */
softsim_status ss_accuracy_rows_compare(ss_accuracy_rows *rows, const char *path,
                                        softsim_error *error);
/* Are the rows of other programs ones that the pictures of these cases can show? A fault for each
 * that is not, with its file and line. */
void ss_accuracy_check_compared(const ss_accuracy_plan *plan, const ss_accuracy_rows *rows,
                                softsim_error *error);
softsim_status ss_accuracy_rows_write(const ss_accuracy_rows *rows, const char *folder,
                                      softsim_error *error);
void ss_accuracy_rows_fini(ss_accuracy_rows *rows);

/* A model on a mesh, over all levels of a material: means of the errors and of the times. NaN
 * errors where a level has none. */
typedef struct ss_accuracy_mean {
    const ss_accuracy_row *first; /* names */
    const char *verdict;          /* of the first level whose is not "good"; else that */
    double error_l2, error_force, p50_us, realtime, to_1pct_ms;
    bool is_calibrated;
    bool is_other; /* another problem than the case's (ss_accuracy_model.note): never chosen */
} ss_accuracy_mean;
typedef struct ss_accuracy_means {
    ss_accuracy_mean *mean;
    int32_t count;
    /* Room for a value of each mean: of a front. */
    double *time, *error;
    bool *is_front;
} ss_accuracy_means;

/* Those of `case_name` and `material`, in the order of the rows; ss_accuracy_means_fini
 * afterwards, whatever the result. */
softsim_status ss_accuracy_means_find(const ss_accuracy_rows *rows, const char *case_name,
                                      const char *material, ss_accuracy_means *out,
                                      softsim_error *error);
void ss_accuracy_means_fini(ss_accuracy_means *means);
/* The most accurate with p50_us <= budget_us; NULL: none. */
const ss_accuracy_mean *ss_accuracy_choose(const ss_accuracy_mean *mean, int32_t count,
                                           double budget_us);
/* Which of `count` points (time, error) no other beats in both; NaN never are. */
void ss_accuracy_pareto(int32_t count, const double *time, const double *error, bool *out_front);

/* ---- pictures ---- */

/* Error against time, forces, and with `has_shapes` the last level's shapes beside the reference,
 * of one case and material. */
softsim_status ss_accuracy_draw(ss_page *page, const ss_accuracy_plan *plan, const ss_case *c,
                                int32_t material, bool has_shapes, const ss_accuracy_rows *rows,
                                softsim_error *error);
