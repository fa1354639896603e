/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-bench ablation: what each omission of a scene's plan is worth. Every one that can be put
 * back is, one by one (pair.h); the results must be the same, or its row fails. One run a scene.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/ablation/pair.h"
#include "bench/bench.h"
#include "bench/core/report.h"
#include "bench/core/sweep.h"
#include "bench/felt/scenes.h"
#include "rt/args.h"
#include "rt/memory.h"
#include "softsim/softsim.h"

enum { NUMBERS = 12, TEXT = 400 };
static const double run_timeout_s = 1800.0;
/* Less is no gain: in every turn, in every creation, and in bytes, which are counted. */
static const double tick_gain = 1.03, create_gain = 1.1, byte_gain = 1.01;

typedef enum row_kind { MEASURED, NOT_POSSIBLE, LOST } row_kind;

typedef struct row {
    row_kind kind;
    char scene[SS_FELT_NAME_SIZE], name[SS_OMISSION_TEXT], note[TEXT];
    ss_ablation_figures figures;
} row;

typedef struct report {
    const char *out;
    ss_arg_list asked, force_include;
    ss_felt_scenes scenes;
    row *rows;
    int32_t count, failed;
} report;

/* ---- a scene ---- */

static softsim_status plan(const char *scene, ss_omission out[SS_MAX_OMISSIONS], int32_t *out_count,
                           softsim_error *error)
{
    const softsim_config config = softsim_default_config();
    return ss_omissions_of_scene(scene, &config, out, out_count, error);
}

static bool is_asked_for(const report *r, const char *name)
{
    bool is_any = r->force_include.count == 0;
    for (int32_t i = 0; i < r->force_include.count; ++i) {
        is_any = is_any || strcmp(r->force_include.value[i], name) == 0;
    }
    return is_any;
}

static void label(const void *context, int32_t index, char out[SS_SWEEP_NAME_SIZE])
{
    const report *r = context;
    int size = snprintf(out, SS_SWEEP_NAME_SIZE, "%.180s", r->scenes.path[index]);
    for (int32_t i = 0; i < r->force_include.count && size < SS_SWEEP_NAME_SIZE; ++i) {
        size += snprintf(out + size, (size_t)(SS_SWEEP_NAME_SIZE - size), ",%s",
                         r->force_include.value[i]);
    }
}

/* "kind|name|note|numbers", a line a row. */
static void measure_one(const char *scene, const ss_omission *omission, FILE *out)
{
    softsim_error error = {.status = SOFTSIM_OK};
    ss_ablation_figures f;
    if (omission->value_count == 0) {
        fprintf(out, "%d|%s|%s\n", NOT_POSSIBLE, omission->name, omission->reason);
        return;
    }
    if (ss_ablation_measure(scene, omission, &f, &error) != SOFTSIM_OK) {
        fprintf(out, "%d|%s|%.*s\n", LOST, omission->name, (int)strcspn(error.text, "\n"),
                error.text);
        return;
    }
    fprintf(out, "%d|%s|", MEASURED, omission->name);
    for (int32_t k = 0; k < omission->value_count; ++k) {
        fprintf(out, "%s%s", k > 0 ? " " : "", omission->value[k]);
    }
    if (f.rate_hz[0] != f.rate_hz[1]) {
        fprintf(out, " (both stepped at %.6g Hz; of itself the plan then takes %.6g Hz)",
                f.rate_hz[0], f.rate_hz[1]);
    }
    const double number[] = {f.rest_us[0],       f.rest_us[1],       f.press_us[0],  f.press_us[1],
                             f.bytes[0],         f.bytes[1],         f.create_ms[0], f.create_ms[1],
                             f.message_bytes[0], f.message_bytes[1], f.rest_least,   f.press_least,
                             f.create_least,     f.force_apart,      f.field_apart};
    fprintf(out, "|%d", f.is_same_state);
    for (size_t k = 0; k < sizeof number / sizeof *number; ++k) {
        fprintf(out, " %.9g", number[k]);
    }
    fputc('\n', out);
}

static softsim_status run(const void *context, int32_t index, FILE *out, softsim_error *error)
{
    const report *r = context;
    const char *scene = r->scenes.path[index];
    ss_omission omission[SS_MAX_OMISSIONS];
    int32_t count = 0;
    const softsim_status status = plan(scene, omission, &count, error);
    for (int32_t i = 0; i < count; ++i) {
        if (is_asked_for(r, omission[i].name)) {
            measure_one(scene, &omission[i], out);
        }
    }
    return status;
}

/* ---- rows ---- */

static bool is_failed(const row *w)
{
    return w->kind == LOST || (w->kind == MEASURED && !ss_ablation_agrees(&w->figures));
}

static bool read_row(char *line, row *out)
{
    ss_ablation_figures *f = &out->figures;
    char *save = NULL;
    const char *kind = strtok_r(line, "|", &save), *name = strtok_r(NULL, "|", &save);
    const char *note = strtok_r(NULL, "|", &save), *numbers = strtok_r(NULL, "|", &save);
    int is_same = 0;
    if (note == NULL) {
        return false;
    }
    out->kind = (row_kind)atoi(kind);
    snprintf(out->name, sizeof out->name, "%s", name);
    snprintf(out->note, sizeof out->note, "%s", note);
    const bool is_good =
        out->kind != MEASURED ||
        (numbers != NULL &&
         sscanf(numbers, "%d %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &is_same,
                &f->rest_us[0], &f->rest_us[1], &f->press_us[0], &f->press_us[1], &f->bytes[0],
                &f->bytes[1], &f->create_ms[0], &f->create_ms[1], &f->message_bytes[0],
                &f->message_bytes[1], &f->rest_least, &f->press_least, &f->create_least,
                &f->force_apart, &f->field_apart) == 16);
    f->is_same_state = is_same != 0;
    return is_good;
}

static softsim_status read_rows(report *r, const ss_sweep_result *result, softsim_error *error)
{
    r->rows = calloc((size_t)r->scenes.count * SS_MAX_OMISSIONS, sizeof *r->rows);
    if (r->rows == NULL) {
        return ss_memory_fault(error);
    }
    for (int32_t s = 0; s < r->scenes.count; ++s) {
        char scene[SS_FELT_NAME_SIZE], *save = NULL;
        ss_felt_name(r->scenes.path[s], scene);
        char *line = strtok_r(result->run[s].text, "\n", &save);
        const bool is_lost = result->run[s].is_lost;
        for (int32_t k = 0; line != NULL && k < SS_MAX_OMISSIONS; ++k) {
            row *w = &r->rows[r->count];
            if (is_lost || !read_row(line, w)) {
                *w = (row){.kind = LOST, .name = "all"};
                snprintf(w->note, sizeof w->note, "%s", line);
            }
            snprintf(w->scene, sizeof w->scene, "%s", scene);
            r->failed += is_failed(w);
            ++r->count;
            line = strtok_r(NULL, "\n", &save);
        }
    }
    return SOFTSIM_OK;
}

static void say_result(const row *w, char *out, size_t size)
{
    const ss_ablation_figures *f = &w->figures;
    if (w->kind != MEASURED) {
        (void)snprintf(out, size, "%s", w->kind == LOST ? "FAILED" : "cannot be put back");
    } else if (f->is_same_state) {
        (void)snprintf(out, size, "same bits");
    } else {
        (void)snprintf(out, size, "%sforce %.1e, field %.1e", is_failed(w) ? "DIFFERS: " : "",
                       f->force_apart, f->field_apart);
    }
}

static bool is_gain(const row *w)
{
    const ss_ablation_figures *f = &w->figures;
    return f->rest_least > tick_gain || f->press_least > tick_gain ||
           f->create_least > create_gain || f->bytes[1] > byte_gain * f->bytes[0] ||
           f->message_bytes[1] > byte_gain * f->message_bytes[0];
}

/* Names of what was measured and gains nothing on any scene: "a, b"; "nothing". */
static void list_gainless(const report *r, char *out, size_t size)
{
    size_t used = 0;
    for (int32_t i = 0; i < r->count; ++i) {
        bool is_any = r->rows[i].kind != MEASURED;
        for (int32_t k = 0; k < r->count; ++k) {
            const row *w = &r->rows[k];
            if (w->kind == MEASURED && strcmp(w->name, r->rows[i].name) == 0) {
                is_any = is_any || k < i || is_gain(w);
            }
        }
        if (!is_any && used < size) {
            used += (size_t)snprintf(out + used, size - used, "%s%s", used > 0 ? ", " : "",
                                     r->rows[i].name);
        }
    }
    if (used == 0) {
        (void)snprintf(out, size, "nothing");
    }
}

/* ---- files ---- */

static void list_numbers(const row *w, double out[NUMBERS])
{
    const ss_ablation_figures *f = &w->figures;
    const double number[NUMBERS] = {f->press_us[0],      f->press_us[1],  f->rest_us[0],
                                    f->rest_us[1],       f->bytes[0],     f->bytes[1],
                                    f->create_ms[0],     f->create_ms[1], f->message_bytes[0],
                                    f->message_bytes[1], f->force_apart,  f->field_apart};
    for (int k = 0; k < NUMBERS; ++k) {
        out[k] = w->kind == MEASURED ? number[k] : (double)NAN;
    }
}

static void put_row(FILE *file, const void *context, int32_t index)
{
    const report *r = context;
    const row *w = &r->rows[index];
    double number[NUMBERS];
    char result[TEXT];
    fprintf(file, "%s,", w->scene);
    ss_csv_text(file, w->name);
    list_numbers(w, number);
    for (int k = 0; k < NUMBERS; ++k) {
        fprintf(file, isnan(number[k]) ? "," : ",%.9g", number[k]);
    }
    say_result(w, result, sizeof result);
    fprintf(file, ",%d,", !is_failed(w));
    ss_csv_text(file, result);
    fputc(',', file);
    ss_csv_text(file, w->note);
    fputc('\n', file);
}

/* Of rows `first` to `end` - 1, a scene's. */
static softsim_status plot(const report *r, int32_t first, int32_t end, ss_page *page,
                           softsim_error *error)
{
    char name[SS_FELT_NAME_SIZE + 16];
    ss_output script;
    int32_t count = 0;
    for (int32_t i = first; i < end; ++i) {
        count += r->rows[i].kind == MEASURED;
    }
    if (count == 0) {
        return SOFTSIM_OK;
    }
    snprintf(name, sizeof name, "ablation-%s", r->rows[first].scene);
    const softsim_status status =
        ss_plot_open_sized(&script, r->out, name, 800, 160 + 50 * count, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("$pairs << EOD\n", script.file);
    for (int32_t i = first; i < end; ++i) {
        const ss_ablation_figures *f = &r->rows[i].figures;
        if (r->rows[i].kind == MEASURED) {
            fprintf(script.file, "\"%s\" %.6g %.6g %.6g %.6g\n", r->rows[i].name,
                    f->press_us[1] / f->press_us[0], f->rest_us[1] / f->rest_us[0],
                    f->bytes[1] / f->bytes[0], f->create_ms[1] / f->create_ms[0]);
        }
    }
    fputs("EOD\nset ytics (", script.file);
    for (int32_t i = first, k = 0; i < end; ++i) {
        if (r->rows[i].kind == MEASURED) {
            fprintf(script.file, "%s\"%s\" %d", k > 0 ? ", " : "", r->rows[i].name, k);
            ++k;
        }
    }
    fprintf(script.file,
            ")\nset yrange [%g:-0.6]\nset xrange [0.5:*]\nset logscale x 2\nset grid x\n"
            "set xlabel 'with it, over without it'\nset key outside top right horizontal samplen 1 "
            "width -2\n"
            "set style fill solid 1\nplot for [k=0:3] $pairs using "
            "((column(k+2)+1)/2):($0-0.27+0.18*k):(abs(column(k+2)-1)/2):(0.08) with "
            "boxxyerror lc k+1 title word('pressed at-rest bytes start-up', k+1)\n",
            count - 0.4);
    return ss_page_plot(page, &script, name, r->rows[first].scene, error);
}

static void put_table(const report *r, ss_page *page)
{
    static const char *const head[] = {
        "scene",        "left out",     "pressed, us",  "with",       "at rest, us", "with",
        "bytes",        "with",         "start-up, ms", "with",       "message B/s", "with",
        "forces apart", "fields apart", "result",       "put back by"};
    ss_page_table_begin(page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t i = 0; i < r->count; ++i) {
        const row *w = &r->rows[i];
        ss_row cells = {.count = 0};
        double number[NUMBERS];
        char result[TEXT];
        ss_row_add(&cells, "%s", w->scene);
        ss_row_add(&cells, "%s", w->name);
        list_numbers(w, number);
        for (int k = 0; k < NUMBERS; ++k) {
            ss_row_add_number(&cells, number[k]);
        }
        say_result(w, result, sizeof result);
        ss_row_add(&cells, "%s", result);
        ss_row_add(&cells, "%s", w->note);
        ss_page_table_row(page, cells.count, cells.cell);
    }
    ss_page_table_end(page);
}

static softsim_status write_page(const report *r, const char *gainless, softsim_error *error)
{
    ss_page page;
    ss_yardstick yardstick;
    softsim_status status = ss_page_open(&page, r->out, "ablation", "softsim: ablation", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_page_text(&page,
                 "What the plan of a scene leaves out, put back one by one by values of the scene "
                 "that change no result. Both worlds take turns in one process: 1.35 s at rest, of "
                 "which the last 0.3 s count, then a press in and out every 0.2 s with the first "
                 "tool, by half its radius. Times are medians of turns of 50 ticks, thread CPU; "
                 "results are the same by the hash of the state, or where forces and displacements "
                 "differ by at most 1e-3 of the largest. %d of %d rows fail.",
                 r->failed, r->count);
    ss_page_text(
        &page,
        "Gains nothing on any scene here: %s. A gain is 3 %% of a tick in every turn, 10 %% of "
        "start-up every time, or 1 %% of bytes.",
        gainless);
    put_table(r, &page);
    for (int32_t first = 0, i = 1; i <= r->count && status == SOFTSIM_OK; ++i) {
        if (i == r->count || strcmp(r->rows[i].scene, r->rows[first].scene) != 0) {
            status = plot(r, first, i, &page, error);
            first = i;
        }
    }
    ss_yardstick_measure(&yardstick);
    ss_page_link(&page, "ablation.csv");
    ss_page_yardstick(&page, &yardstick);
    if (status == SOFTSIM_OK) {
        status = ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}

static void print_rows(const report *r)
{
    printf("%-18s %-34s %17s %17s %17s %15s %15s  result\n", "scene", "left out", "us pressed",
           "us at rest", "kB", "ms start-up", "message kB/s");
    for (int32_t i = 0; i < r->count; ++i) {
        const row *w = &r->rows[i];
        const ss_ablation_figures *f = &w->figures;
        char result[TEXT];
        say_result(w, result, sizeof result);
        if (w->kind != MEASURED) {
            printf("%-18s %-34s %s: %s\n", w->scene, w->name, result, w->note);
            continue;
        }
        printf("%-18s %-34s %8.1f %8.1f %8.1f %8.1f %8.0f %8.0f %7.1f %7.1f %7.1f %7.1f  %s\n",
               w->scene, w->name, f->press_us[0], f->press_us[1], f->rest_us[0], f->rest_us[1],
               1e-3 * f->bytes[0], 1e-3 * f->bytes[1], f->create_ms[0], f->create_ms[1],
               1e-3 * f->message_bytes[0], 1e-3 * f->message_bytes[1], result);
    }
}

/* ---- the report ---- */

static softsim_status write_all(void *context, const ss_sweep_result *result, softsim_error *error)
{
    static const char head[] =
        "scene,omission,press_us_without,press_us_with,rest_us_without,rest_us_with,bytes_without,"
        "bytes_with,create_ms_without,create_ms_with,message_bytes_per_s_without,"
        "message_bytes_per_s_with,force_difference,field_difference,is_good,result,note";
    report *r = context;
    char gainless[1024];
    softsim_status status = read_rows(r, result, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    list_gainless(r, gainless, sizeof gainless);
    print_rows(r);
    printf("gains nothing on any scene here: %s\n", gainless);
    status = ss_report_csv_write(r->out, "ablation", head, r->count, put_row, r, error);
    status = status == SOFTSIM_OK ? write_page(r, gainless, error) : status;
    if (status == SOFTSIM_OK) {
        printf("%s/ablation.html\n", r->out);
    }
    return status;
}

/* What is asked for by name is left out by every scene that is asked for. */
static softsim_status check_names(const report *r, softsim_error *error)
{
    ss_omission omission[SS_MAX_OMISSIONS];
    const bool is_asked = r->asked.count > 0 && r->force_include.count > 0;
    softsim_status status = SOFTSIM_OK;
    for (int32_t s = 0; is_asked && s < r->scenes.count && status == SOFTSIM_OK; ++s) {
        int32_t count = 0;
        status = plan(r->scenes.path[s], omission, &count, error);
        for (int32_t i = 0; status == SOFTSIM_OK && i < r->force_include.count; ++i) {
            if (ss_omission_find(omission, count, r->force_include.value[i], error) == NULL) {
                status = error->status;
            }
        }
    }
    return status;
}

static softsim_status measure(report *r, softsim_error *error)
{
    const ss_sweep sweep = {.folder = r->out,
                            .name = "ablation",
                            .count = r->scenes.count,
                            .jobs = 1, /* times would disturb one another */
                            .timeout_s = run_timeout_s,
                            .context = r,
                            .label = label,
                            .run = run};
    int32_t lost = 0; /* a row says so */
    return ss_sweep_and_report(&sweep, write_all, r, &lost, error);
}

static int run_report(int argc, char **argv)
{
    static report r;
    r = (report){.out = "ablation-report"};
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_arg rows[] = {
        SS_LIST("--scene", &r.asked, "S.yaml", "a scene (default: all bundled ones)"),
        SS_LIST("--force-include", &r.force_include, "NAME",
                "only that omission, by its name in softsimd --explain (default: all)"),
        SS_TEXT("--out", &r.out, "DIR", "for the report (ablation-report)"),
    };
    const ss_args_result parsed = SS_ARGS_OPTIONS(
        argc, argv, "[options]",
        "Puts back what the plan of a scene leaves out, one by one: what it costs, and whether\n"
        "results are the same. Exits 1 where they are not.",
        rows, &error);
    int exit_code = 0;
    if (!ss_args_may_run(argv[0], parsed, &error, &exit_code)) {
        return exit_code;
    }
    ss_felt_list_scenes(&r.asked, &r.scenes, &error);
    softsim_status status = error.fault_count > 0 ? error.status : check_names(&r, &error);
    status = status == SOFTSIM_OK ? ss_report_begin(r.out, NULL, &error) : status;
    status = status == SOFTSIM_OK ? measure(&r, &error) : status;
    free(r.rows);
    exit_code = ss_args_finish(argv[0], status, &error);
    return exit_code == EXIT_SUCCESS && r.failed > 0 ? EXIT_FAILURE : exit_code;
}

const ss_report_class ss_report_ablation = {
    .name = "ablation",
    .about = "what a scene's plan leaves out, put back one by one",
    .run = run_report};
