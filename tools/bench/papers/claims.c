/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "bench/papers/paper.h"
#include "rt/clock.h"

static const char *const result_names[] = {"pass", "fail", "differs"};
static const char *const source_names[] = {"paper", "closed form", "independent"};

/* ---- adding ---- */

/* The next claim with its text; the last slot is used again and again when all are taken, so that
 * a count at the limit shows itself. */
static ss_claim *next(ss_paper *paper, const char *figure, ss_claim_source source,
                      const char *claim, va_list arguments)
{
    ss_claim *to =
        &paper->claim[paper->claim_count < SS_PAPER_MAX_CLAIMS ? paper->claim_count++
                                                               : SS_PAPER_MAX_CLAIMS - 1];
    *to = (ss_claim){.result = SS_CLAIM_FAIL, .source = source};
    snprintf(to->figure, sizeof to->figure, "%s", figure);
    vsnprintf(to->claim, sizeof to->claim, claim, arguments);
    return to;
}

void ss_claim_add(ss_paper *paper, const char *figure, ss_claim_source source,
                  ss_claim_result result, const char *expected, const char *measured,
                  const char *claim, ...)
{
    va_list arguments;
    va_start(arguments, claim);
    ss_claim *to = next(paper, figure, source, claim, arguments);
    va_end(arguments);
    snprintf(to->expected, sizeof to->expected, "%s", expected);
    snprintf(to->measured, sizeof to->measured, "%s", measured);
    to->result = result;
}

void ss_claim_near(ss_paper *paper, const char *figure, ss_claim_source source, double expected,
                   double measured, double tolerance, const char *claim, ...)
{
    va_list arguments;
    va_start(arguments, claim);
    ss_claim *to = next(paper, figure, source, claim, arguments);
    va_end(arguments);
    const double error = fabs(measured - expected);
    snprintf(to->expected, sizeof to->expected, "%.5g", expected);
    snprintf(to->tolerance, sizeof to->tolerance, "%g", tolerance);
    if (expected == 0.0) {
        snprintf(to->measured, sizeof to->measured, "%.5g", measured);
    } else {
        snprintf(to->measured, sizeof to->measured, "%.5g (%+.2g %%)", measured,
                 100.0 * (measured / expected - 1.0));
    }
    to->result = error <= tolerance * fabs(expected) ? SS_CLAIM_PASS : SS_CLAIM_FAIL;
}

void ss_claim_limit(ss_paper *paper, const char *figure, ss_claim_source source, bool is_most,
                    double limit, double measured, const char *claim, ...)
{
    va_list arguments;
    va_start(arguments, claim);
    ss_claim *to = next(paper, figure, source, claim, arguments);
    va_end(arguments);
    /* Thousands in full: "at least 9000". */
    const bool is_large = fabs(limit) >= 100.0 && fabs(limit) < 1e6;
    snprintf(to->expected, sizeof to->expected, is_large ? "at %s %.0f" : "at %s %.3g",
             is_most ? "most" : "least", limit);
    snprintf(to->measured, sizeof to->measured,
             fabs(measured) >= 1000.0 && fabs(measured) < 1e6 ? "%.0f" : "%.4g", measured);
    to->result = (is_most ? measured <= limit : measured >= limit) ? SS_CLAIM_PASS : SS_CLAIM_FAIL;
}

void ss_claim_search(ss_paper *paper, const char *search, ...)
{
    if (paper->claim_count == 0) {
        return;
    }
    ss_claim *to = &paper->claim[paper->claim_count - 1];
    va_list arguments;
    va_start(arguments, search);
    vsnprintf(to->search, sizeof to->search, search, arguments);
    va_end(arguments);
}

void ss_paper_miss(ss_paper *paper, const char *why, const char *what, ...)
{
    if (paper->missing_count == SS_PAPER_MAX_MISSING) {
        return;
    }
    ss_missing *to = &paper->missing[paper->missing_count++];
    va_list arguments;
    va_start(arguments, what);
    vsnprintf(to->what, sizeof to->what, what, arguments);
    va_end(arguments);
    snprintf(to->why, sizeof to->why, "%s", why);
}

int32_t ss_paper_count(const ss_paper *paper, ss_claim_result result)
{
    int32_t count = 0;
    for (int32_t i = 0; i < paper->claim_count; ++i) {
        count += paper->claim[i].result == result ? 1 : 0;
    }
    return count;
}

/* ---- files and the page ---- */

softsim_status ss_paper_csv_open(const ss_paper *paper, ss_output *csv, const char *name,
                                 const char *head, softsim_error *error)
{
    return ss_report_csv_open(csv, paper->folder, name, head, error);
}

static softsim_status link_csv(ss_paper *paper, const char *name, softsim_status written)
{
    char file[96];
    if (written == SOFTSIM_OK) {
        snprintf(file, sizeof file, "%s.csv", name);
        ss_page_link(&paper->page, file);
    }
    return written;
}

softsim_status ss_paper_csv_write(ss_paper *paper, const char *name, const char *head,
                                  int32_t count,
                                  void (*put_row)(FILE *file, const void *context, int32_t row),
                                  const void *context, softsim_error *error)
{
    return link_csv(paper, name,
                    ss_report_csv_write(paper->folder, name, head, count, put_row, context, error));
}

softsim_status ss_paper_csv_close(ss_paper *paper, ss_output *csv, const char *name,
                                  softsim_error *error)
{
    return link_csv(paper, name, ss_output_commit(csv, error));
}

softsim_status ss_paper_csv_end(ss_paper *paper, ss_output *csv, const char *name,
                                softsim_status status, softsim_error *error)
{
    if (status == SOFTSIM_OK) {
        return ss_paper_csv_close(paper, csv, name, error);
    }
    ss_output_abandon(csv);
    return status;
}

enum { CLAIM_CELLS = 8 };

/* A claim's row of the table; the page leaves out the first cell, the paper's name. */
static void fill_cells(const ss_paper *paper, const ss_claim *at, const char *cell[CLAIM_CELLS])
{
    const char *const all[CLAIM_CELLS] = {paper->name,
                                          at->figure,
                                          at->claim,
                                          at->expected,
                                          at->measured,
                                          at->tolerance,
                                          source_names[at->source],
                                          result_names[at->result]};
    memcpy(cell, all, sizeof all);
}

static void put_claim(FILE *file, const void *context, int32_t row)
{
    const ss_paper *paper = context;
    const char *cell[CLAIM_CELLS];
    fill_cells(paper, &paper->claim[row], cell);
    for (size_t k = 0; k < CLAIM_CELLS; ++k) {
        if (k > 0) {
            fputc(',', file);
        }
        ss_csv_text(file, cell[k]);
    }
    fputc('\n', file);
}

softsim_status ss_paper_write_claims(const ss_paper *paper, softsim_error *error)
{
    return ss_report_csv_write(paper->folder, "claims",
                               "paper,figure,claim,expected,measured,tolerance,source,result",
                               paper->claim_count, put_claim, paper, error);
}

void ss_paper_show_claims(ss_paper *paper)
{
    static const char *const head[CLAIM_CELLS - 1] = {"figure", "claim", "expected", "measured",
                                                      "within", "from",  "verdict"};
    if (paper->shown_count == paper->claim_count) {
        return;
    }
    ss_page_table_begin(&paper->page, CLAIM_CELLS - 1, head);
    for (; paper->shown_count < paper->claim_count; ++paper->shown_count) {
        const char *cell[CLAIM_CELLS];
        fill_cells(paper, &paper->claim[paper->shown_count], cell);
        ss_page_table_row(&paper->page, CLAIM_CELLS - 1, cell + 1);
    }
    ss_page_table_end(&paper->page);
}

void ss_paper_progress(ss_paper *paper, double share)
{
    if (!paper->is_shown) {
        return;
    }
    const double done = (paper->weight_done + share * paper->weight) / paper->weight_all;
    const double elapsed_s = 1e-9 * (double)(ss_clock_now_ns() - paper->start_ns);
    fprintf(stderr, "\r%3.0f %%  %-28s", 100.0 * done, paper->section);
    if (done > 0.02) {
        fprintf(stderr, " about %.0f s left ", elapsed_s * (1.0 - done) / done);
    }
}

softsim_status ss_paper_run_sections(ss_paper *paper, int32_t count,
                                     const ss_paper_section *section, softsim_error *error)
{
    softsim_status status = SOFTSIM_OK;
    for (int32_t k = 0; k < count; ++k) {
        paper->weight_all += section[k].weight;
    }
    for (int32_t k = 0; status == SOFTSIM_OK && k < count; ++k) {
        paper->section = section[k].heading;
        paper->weight = section[k].weight;
        ss_paper_progress(paper, 0.0);
        ss_page_heading(&paper->page, section[k].heading);
        status = section[k].run(paper, error);
        ss_paper_show_claims(paper);
        paper->weight_done += section[k].weight;
    }
    return status;
}

void ss_paper_write_missing(ss_paper *paper)
{
    static const char *const head[] = {"what", "what the program says"};
    if (paper->missing_count == 0) {
        return;
    }
    ss_page_heading(&paper->page, "Not in this program");
    ss_page_text(&paper->page,
                 "These runs need a feature that the program which made this page refuses; their "
                 "claims were not made.");
    ss_page_table_begin(&paper->page, 2, head);
    for (int32_t i = 0; i < paper->missing_count; ++i) {
        const char *const cell[] = {paper->missing[i].what, paper->missing[i].why};
        ss_page_table_row(&paper->page, 2, cell);
    }
    ss_page_table_end(&paper->page);
}

void ss_paper_write_verdict(ss_paper *paper)
{
    static const char *const head[] = {"result", "figure", "claim", "measured", "search"};
    const int32_t pass = ss_paper_count(paper, SS_CLAIM_PASS);
    ss_page_heading(&paper->page, "Verdict");
    ss_page_text(&paper->page, "%d claims: %d pass, %d fail, %d differ.%s", paper->claim_count,
                 pass, ss_paper_count(paper, SS_CLAIM_FAIL),
                 ss_paper_count(paper, SS_CLAIM_DIFFERS),
                 pass < paper->claim_count ? " Those that do not pass:" : "");
    if (pass < paper->claim_count) {
        ss_page_table_begin(&paper->page, (int32_t)(sizeof head / sizeof *head), head);
        for (int32_t i = 0; i < paper->claim_count; ++i) {
            const ss_claim *at = &paper->claim[i];
            const char *const cell[] = {result_names[at->result], at->figure, at->claim,
                                        at->measured, at->search[0] != '\0' ? at->search : "none"};
            if (at->result != SS_CLAIM_PASS) {
                ss_page_table_row(&paper->page, (int32_t)(sizeof cell / sizeof *cell), cell);
            }
        }
        ss_page_table_end(&paper->page);
    }
    ss_page_link(&paper->page, "claims.csv");
}
