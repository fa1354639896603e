/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double run_timeout_s = 1800.0;

/* ---- options ---- */

static int32_t read_numbers(const char *text, bool is_whole, double low, double high, int32_t most,
                            double *out)
{
    for (int32_t count = 0; count < most; ++count) {
        char *end = NULL;
        out[count] = strtod(text, &end);
        if (end == text || !(out[count] >= low && out[count] <= high) ||
            (is_whole && out[count] != round(out[count]))) {
            return -1;
        }
        if (*end != ',') {
            return *end == '\0' ? count + 1 : -1;
        }
        text = end + 1;
    }
    return -1;
}

int32_t ss_felt_numbers(const char *option, bool is_whole, const char *text, double low,
                        double high, int32_t most, double *out, softsim_error *error)
{
    const int32_t count = read_numbers(text, is_whole, low, high, most, out);
    if (count < 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%s: '%s' is not up to %d %snumbers from %g to %g with commas between "
                          "them",
                          option, text, most, is_whole ? "whole " : "", low, high);
    }
    return count;
}

/* ---- files ---- */

bool ss_felt_has_rows(const ss_sweep_run *run)
{
    return !run->is_lost && run->text[0] != '\0';
}

void ss_felt_page_lost(const ss_felt_report *report, ss_page *page, const ss_sweep_run *run)
{
    for (int32_t k = 0; k < report->kind->runs; ++k) {
        if (run[k].is_lost) {
            ss_page_text(page, "%s: not run: %s", report->kind->run_name(k), run[k].text);
        }
    }
}

softsim_status ss_felt_plot_open(const ss_felt_report *report, ss_output *script,
                                 const char *picture, int32_t panels, int32_t panel_height,
                                 const char *more, softsim_error *error)
{
    const softsim_status status =
        ss_plot_open_sized(script, report->out, picture, 900, 60 + panel_height * panels, error);
    if (status == SOFTSIM_OK) {
        fprintf(script->file,
                "set datafile separator ','\nset multiplot layout %d,1\nset grid\n"
                "set ylabel 'force, N'\n%sset key outside right top\n",
                panels, more);
    }
    return status;
}

/* The page, with a link to the table. */
static softsim_status write_page(const ss_felt_report *r, const ss_sweep_result *result,
                                 softsim_error *error)
{
    char table[64];
    ss_page page = {.folder = NULL};
    softsim_status status = ss_page_open(&page, r->out, r->kind->name, r->kind->title, error);
    if (status == SOFTSIM_OK) {
        status = r->kind->write_page(r, result, &page, error);
    }
    if (status == SOFTSIM_OK) {
        snprintf(table, sizeof table, "%s.csv", r->kind->name);
        ss_page_link(&page, table);
        status = ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}

static softsim_status write_csv(const ss_felt_report *r, const ss_sweep_result *result,
                                softsim_error *error)
{
    ss_output csv;
    const softsim_status status =
        ss_report_csv_open(&csv, r->out, r->kind->name, r->kind->head, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < result->count; ++i) {
        if (!result->run[i].is_lost) {
            fputs(result->run[i].text, csv.file);
        }
    }
    return ss_output_commit(&csv, error);
}

static void print_rows(const ss_felt_report *r, const ss_sweep_result *result)
{
    puts(r->kind->head);
    for (int32_t i = 0; i < result->count; ++i) {
        if (result->run[i].is_lost) {
            char name[SS_FELT_NAME_SIZE];
            ss_felt_name(r->scenes.path[i / r->kind->runs], name);
            printf("%s, %s: not run: %s\n", name, r->kind->run_name(i % r->kind->runs),
                   result->run[i].text);
        } else {
            fputs(result->run[i].text, stdout);
        }
    }
    if (r->kind->print_more != NULL) {
        r->kind->print_more(result);
    }
    printf("%s/%s.html\n", r->out, r->kind->name);
}

static softsim_status write_all(void *context, const ss_sweep_result *result, softsim_error *error)
{
    const ss_felt_report *r = context;
    softsim_status status = write_csv(r, result, error);
    status = status == SOFTSIM_OK ? write_page(r, result, error) : status;
    if (status == SOFTSIM_OK) {
        print_rows(r, result);
    }
    return status;
}

/* ---- all of it ---- */

static softsim_status sweep_and_report(ss_felt_report *r, int32_t *out_lost, softsim_error *error)
{
    const ss_sweep sweep = {.folder = r->out,
                            .name = r->kind->name,
                            .count = r->scenes.count * r->kind->runs,
                            .jobs = (int32_t)r->jobs,
                            .timeout_s = run_timeout_s,
                            .context = r,
                            .label = r->kind->label,
                            .run = r->kind->run};
    return ss_sweep_and_report(&sweep, write_all, r, out_lost, error);
}

int ss_felt_report_run(int argc, char **argv, const ss_felt_kind *kind)
{
    ss_felt_report *r = calloc(1, kind->size);
    softsim_error error = {.status = SOFTSIM_OK};
    int exit_code = EXIT_FAILURE;
    int32_t lost = 0;
    if (r == NULL) {
        fputs("softsim-bench felt: out of memory\n", stderr);
        return exit_code;
    }
    r->kind = kind;
    r->out = "felt-report";
    r->jobs = 1;
    ss_args_result parsed = kind->parse(argc, argv, r, &error);
    if (parsed == SS_ARGS_RUN) {
        ss_felt_list_scenes(&r->scene_list, &r->scenes, &error);
        parsed = error.fault_count > 0 ? SS_ARGS_BAD : parsed;
    }
    if (ss_args_may_run(argv[0], parsed, &error, &exit_code)) {
        softsim_status status = ss_report_begin(r->out, NULL, &error);
        status = status == SOFTSIM_OK ? sweep_and_report(r, &lost, &error) : status;
        exit_code = ss_args_finish(argv[0], status, &error);
        exit_code = exit_code == 0 && lost > 0 ? EXIT_FAILURE : exit_code;
    }
    free(r);
    return exit_code;
}
