/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench paper NAME: repeats the figures and tables of a paper with this program's own
 * code, and says of each claim whether it holds. Exit 1 when any fails.
 */
#include "bench/papers/paper.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/bench.h"
#include "bench/core/child.h"
#include "process.h"
#include "rt/args.h"
#include "rt/clock.h"

static const struct {
    const char *name, *title;
    softsim_status (*run)(ss_paper *paper, softsim_error *error);
} papers[] = {
    {"zhong2006", "softsim: Zhong et al. 2006, haptic deformation by a cellular neural network",
     ss_paper_zhong},
    {"hybrid", "softsim: a hybrid of finite elements and a particle layer for haptic interaction",
     ss_paper_hybrid},
    {"zhang2018", "softsim: Zhang et al. 2018, ChainMail as a cellular neural network",
     ss_paper_zhang},
};
enum { PAPER_COUNT = sizeof papers / sizeof papers[0] };

typedef struct options {
    const char *name, *out;
    bool is_quick;
    int paper;
} options;

static ss_args_result parse_options(int argc, char **argv, options *o, softsim_error *error)
{
    *o = (options){.out = "paper-report", .paper = -1};
    const ss_arg rows[] = {
        SS_TEXT("--out", &o->out, "DIR", "for the report (paper-report)"),
        SS_FLAG("--quick", &o->is_quick, "shorter comparisons with other readings of the paper"),
    };
    const ss_args_result result =
        ss_args_parse(argc, argv, "[options] zhong2006|zhang2018|hybrid",
                      "Repeats a paper's figures and tables; exit 1 when a claim does not hold.",
                      rows, (int32_t)(sizeof rows / sizeof rows[0]), &o->name, 1, 1, NULL, error);
    for (int i = 0; result == SS_ARGS_RUN && o->name != NULL && i < PAPER_COUNT; ++i) {
        o->paper = strcmp(o->name, papers[i].name) == 0 ? i : o->paper;
    }
    if (result == SS_ARGS_RUN && o->name != NULL && o->paper < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "'%s' is not a paper known here: zhong2006, zhang2018, hybrid", o->name);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

static void print_summary(const ss_paper *paper)
{
    for (int32_t i = 0; i < paper->claim_count; ++i) {
        const ss_claim *at = &paper->claim[i];
        if (at->result != SS_CLAIM_PASS) {
            printf("%s  %s: %s: expected %s, measured %s\n",
                   at->result == SS_CLAIM_FAIL ? "fail" : "differs", at->figure, at->claim,
                   at->expected, at->measured);
        }
    }
    for (int32_t i = 0; i < paper->missing_count; ++i) {
        printf("missing  %s: %s\n", paper->missing[i].what, paper->missing[i].why);
    }
    printf("%d claims: %d pass, %d fail, %d differ from the paper's words; %d things are not in "
           "this program\n%s/%s.html\n",
           paper->claim_count, ss_paper_count(paper, SS_CLAIM_PASS),
           ss_paper_count(paper, SS_CLAIM_FAIL), ss_paper_count(paper, SS_CLAIM_DIFFERS),
           paper->missing_count, paper->folder, paper->name);
}

static softsim_status make_report(ss_paper *paper, int which, softsim_error *error)
{
    ss_yardstick yardstick;
    softsim_status status = ss_report_begin(paper->folder, paper->temporary, error);
    if (status == SOFTSIM_OK && !ss_child_own_folder(paper->bin, sizeof paper->bin)) {
        status = SOFTSIM_ERROR_SYSTEM;
        softsim_error_add(error, status, "cannot find this program's own folder");
    }
    if (status == SOFTSIM_OK) {
        status = ss_page_open(&paper->page, paper->folder, paper->name, papers[which].title, error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_yardstick_measure(&yardstick);
    status = papers[which].run(paper, error);
    if (paper->is_shown) {
        fprintf(stderr, "\r%70s\r", "");
    }
    ss_page_yardstick(&paper->page, &yardstick);
    if (status == SOFTSIM_OK) {
        status = ss_paper_write_claims(paper, error);
    }
    return status == SOFTSIM_OK ? ss_page_close(&paper->page, error) : status;
}

static int run_report(int argc, char **argv)
{
    static ss_paper paper; /* large */
    options o;
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_args_result parsed = parse_options(argc, argv, &o, &error);
    int exit_code = 0;
    if (!ss_args_may_run(argv[0], parsed, &error, &exit_code)) {
        return exit_code;
    }
    paper.name = papers[o.paper].name;
    paper.folder = o.out;
    paper.is_quick = o.is_quick;
    paper.is_shown = isatty(STDERR_FILENO) == 1;
    paper.start_ns = ss_clock_now_ns();
    const softsim_status status = make_report(&paper, o.paper, &error);
    ss_page_abandon(&paper.page);
    ss_scratch_remove(paper.temporary);
    if (status == SOFTSIM_OK) {
        print_summary(&paper);
    }
    exit_code = ss_args_finish(argv[0], status, &error);
    return ss_paper_count(&paper, SS_CLAIM_FAIL) > 0 ? EXIT_FAILURE : exit_code;
}

const ss_report_class ss_report_paper = {
    .name = "paper",
    .about = "the figures and tables of a paper, each claim passed or failed",
    .run = run_report};
