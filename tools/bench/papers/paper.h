/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What the reports on papers share: the claims and their verdicts, the page and its sections,
 * progress, runs of scenes without LCM.
 *
 * A claim has an expected value with its source and tolerance, a measured value and a result: pass,
 * fail, or differs where the paper's own words hold in no well-posed reading. The source is the
 * paper (a figure or a sentence of it), a closed form, or an independent program
 * (papers/zhong2006/net.h, papers/zhong2006/motion.h, papers/zhang2018/reference.h,
 * papers/hybrid/reference.h, core/static_fem.h: double precision, no code shared with the models);
 * never what the models or a prototype of them once printed. A claim that fails or differs carries
 * the search that was made, and the page's closing note lists both. What the built program refuses
 * to do is missing, not failed: the page says so. Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "bench/core/report.h"
#include "case/scratch.h"
#include "output.h"
#include "softsim/softsim.h"
#include "softsim/types.h"

/* ---- claims ---- */

/* Of two codes for one equation, one of them in single precision. */
#define SS_CODE_TOLERANCE 1e-3

typedef enum ss_claim_result { SS_CLAIM_PASS, SS_CLAIM_FAIL, SS_CLAIM_DIFFERS } ss_claim_result;

typedef enum ss_claim_source { SS_FROM_PAPER, SS_FROM_CLOSED_FORM, SS_FROM_CODE } ss_claim_source;

typedef struct ss_claim {
    char figure[16]; /* as the paper calls it */
    char claim[256], expected[96], measured[320];
    char tolerance[16]; /* a fraction of `expected`; empty where that is a bound or words */
    char search[640];   /* what was tried, of a claim that does not pass; empty: nothing to try */
    ss_claim_source source;
    ss_claim_result result;
} ss_claim;

typedef struct ss_missing {
    char what[128], why[256];
} ss_missing;

enum { SS_PAPER_MAX_CLAIMS = 320, SS_PAPER_MAX_MISSING = 32 };

typedef struct ss_paper {
    const char *name;                /* of the paper, in claims.csv */
    const char *folder;              /* of the report */
    char temporary[SS_SCRATCH_PATH]; /* for scenes and meshes */
    char bin[4096];                  /* where softsim-mesh is */
    bool is_quick;
    ss_page page;
    ss_claim claim[SS_PAPER_MAX_CLAIMS];
    int32_t claim_count, shown_count; /* shown: already in a table of the page */
    ss_missing missing[SS_PAPER_MAX_MISSING];
    int32_t missing_count;
    /* progress */
    bool is_shown;
    int64_t start_ns;
    double weight, weight_done, weight_all; /* of the present section, those before, all */
    const char *section;
    void *shared; /* by the paper's sections, which know its type; NULL: nothing */
} ss_paper;

typedef struct ss_paper_section {
    const char *heading;
    softsim_status (*run)(ss_paper *paper, softsim_error *error);
    double weight; /* seconds, roughly */
} ss_paper_section;

/* Adds a claim; `claim`, `expected` and `measured` are copied, the claim in printf form. */
void ss_claim_add(ss_paper *paper, const char *figure, ss_claim_source source,
                  ss_claim_result result, const char *expected, const char *measured,
                  const char *claim, ...) __attribute__((format(printf, 7, 8)));
/* Passes when `measured` is within `tolerance` (a fraction) of `expected`. */
void ss_claim_near(ss_paper *paper, const char *figure, ss_claim_source source, double expected,
                   double measured, double tolerance, const char *claim, ...)
    __attribute__((format(printf, 7, 8)));
/* Passes when `measured` is at most (`is_most`) or at least `limit`. */
void ss_claim_limit(ss_paper *paper, const char *figure, ss_claim_source source, bool is_most,
                    double limit, double measured, const char *claim, ...)
    __attribute__((format(printf, 7, 8)));
#define ss_claim_at_most(paper, figure, source, limit, ...)                                        \
    ss_claim_limit(paper, figure, source, true, limit, __VA_ARGS__)
#define ss_claim_at_least(paper, figure, source, limit, ...)                                       \
    ss_claim_limit(paper, figure, source, false, limit, __VA_ARGS__)
/* What was tried to make the last claim hold, and with what result; shown where it does not pass.
 */
void ss_claim_search(ss_paper *paper, const char *search, ...)
    __attribute__((format(printf, 2, 3)));
/* Something that this program refuses; `why` is its own words. */
void ss_paper_miss(ss_paper *paper, const char *why, const char *what, ...)
    __attribute__((format(printf, 3, 4)));
int32_t ss_paper_count(const ss_paper *paper, ss_claim_result result);
softsim_status ss_paper_write_claims(const ss_paper *paper, softsim_error *error);

/* ---- the page ---- */

/* A table of the claims added since the last one. */
void ss_paper_show_claims(ss_paper *paper);
/* Opens `name`.csv in the report's folder with a head line. */
softsim_status ss_paper_csv_open(const ss_paper *paper, ss_output *csv, const char *name,
                                 const char *head, softsim_error *error);
/* All of it by ss_report_csv_write, and its link in the page. */
softsim_status ss_paper_csv_write(ss_paper *paper, const char *name, const char *head,
                                  int32_t count,
                                  void (*put_row)(FILE *file, const void *context, int32_t row),
                                  const void *context, softsim_error *error);
/* Commits it and puts a link to it into the page. */
softsim_status ss_paper_csv_close(ss_paper *paper, ss_output *csv, const char *name,
                                  softsim_error *error);
/* Closes it where `status` is good, else it is as if it had not been opened; the end's status. */
softsim_status ss_paper_csv_end(ss_paper *paper, ss_output *csv, const char *name,
                                softsim_status status, softsim_error *error);
/* `share` (0 to 1) of the present section is done; on a terminal, with the time that is left. */
void ss_paper_progress(ss_paper *paper, double share);
/* Runs the sections in order, each under its heading and followed by its claims; the first that
 * does not return SOFTSIM_OK is the last. */
softsim_status ss_paper_run_sections(ss_paper *paper, int32_t count,
                                     const ss_paper_section *section, softsim_error *error);
/* A table of what is missing; nothing when all is there. */
void ss_paper_write_missing(ss_paper *paper);
/* The closing note: how many claims pass, fail and differ, and each that does not pass, with the
 * search that was made. */
void ss_paper_write_verdict(ss_paper *paper);

/* ---- runs of scenes ---- */

/* A body as the program sees it. */
typedef struct ss_trial_body {
    char object[256]; /* the scene's lines under `object:`, indented, without `fixed` */
    int32_t node_count, triangle_count;
    double (*rest)[3]; /* m */
    int32_t (*triangle)[3];
} ss_trial_body;

typedef struct ss_trial_plan {
    const ss_trial_body *body;
    const char *fixed; /* value of `fixed:`; NULL: none */
    const char *model; /* lines under `model:`, indented */
    const char *rest;  /* further lines of the scene; NULL: none */
    double step_s;     /* 0: the scene's own rates */
} ss_trial_plan;

typedef struct ss_trial {
    softsim_world *world; /* NULL when refused */
    char reason[256];     /* why it was refused */
    int32_t node_count;
    double step_s, time_s;
    double (*position)[3], (*u)[3], (*v)[3]; /* as last read */
} ss_trial;

/* What the object of these lines is; a refusal leaves node_count 0 and its reason. */
softsim_status ss_trial_look(const ss_paper *paper, const char *object, ss_trial_body *out_body,
                             char out_reason[256], softsim_error *error);
void ss_trial_body_fini(ss_trial_body *body);
/* Creates the world of a plan at rest. A refusal is no error: world is then NULL. */
softsim_status ss_trial_begin(const ss_paper *paper, const ss_trial_plan *plan, ss_trial *out_trial,
                              softsim_error *error);
void ss_trial_end(ss_trial *trial);
/* Steps without poses, then reads the nodes. SOFTSIM_ERROR_SYSTEM when the program is stopped. */
softsim_status ss_trial_run(ss_trial *trial, int32_t ticks, softsim_error *error);
/* Values a node (rows node,value) as a file beside the scenes. */
softsim_status ss_trial_write_field(const ss_paper *paper, const char *name, int32_t count,
                                    const double *value, softsim_error *error);
/* A surface as MSH beside the scenes. */
softsim_status ss_trial_write_mesh(const ss_paper *paper, const char *name, int32_t node_count,
                                   const double (*position)[3], int32_t triangle_count,
                                   const int32_t (*triangle)[3], softsim_error *error);
/* softsim-mesh generate `shape` with exactly `points` points, `size_mm` NULL for its own. */
softsim_status ss_trial_generate(const ss_paper *paper, const char *name, const char *shape,
                                 int32_t points, const char *size_mm, softsim_error *error);
/* The same filled with tetrahedra. */
softsim_status ss_trial_generate_solid(const ss_paper *paper, const char *name, const char *shape,
                                       int32_t points, const char *size_mm, softsim_error *error);

/* ---- papers ---- */

/* Zhong, Shirinzadeh, Alici, Smith 2006. Fills the page; claims tell the rest. */
softsim_status ss_paper_zhong(ss_paper *paper, softsim_error *error);
/* The hybrid of finite elements and particles. */
softsim_status ss_paper_hybrid(ss_paper *paper, softsim_error *error);
/* Zhang, Zhong, Smith, Gu 2018. */
softsim_status ss_paper_zhang(ss_paper *paper, softsim_error *error);
