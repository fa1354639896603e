/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The rows of softsim-bench scaling: as CSV, on stdout, and on the page with its pictures. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench/accuracy/models.h"
#include "bench/core/report.h"
#include "bench/scaling/scaling.h"
#include "bench/stability/stress_case.h"

/* ---- files ---- */

static void put_numbers(FILE *file, const double *value, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (isnan(value[i])) {
            fputc(',', file);
        } else {
            fprintf(file, ",%.6g", value[i]);
        }
    }
}

static void put_row(FILE *file, const void *context, int32_t i)
{
    const ss_scaling *r = context;
    const ss_scaling_row *at = &r->row[i];
    fprintf(file, "%d,%d,%s", at->points, at->nodes, at->name);
    const double costs[] = {at->p50_us,   at->p99_us,       at->substeps, at->p50_us / at->substeps,
                            at->paper_ms, 100.0 * at->jump, at->balance};
    put_numbers(file, costs, sizeof costs / sizeof *costs);
    fprintf(file, ",%d", at->active_nodes);
    put_numbers(file, (const double[]){at->direct_error, at->apart, at->prototype_us}, 3);
    fputc(',', file);
    ss_csv_text(file, at->verdict);
    fprintf(file, ",%s", at->model);
    put_numbers(file, (const double[]){at->create_s, at->memory_mb, at->peak_mb}, 3);
    fputc(',', file);
    ss_csv_text(file, at->solver);
    fputc('\n', file);
}

softsim_status ss_scaling_write_csv(const ss_scaling *r, softsim_error *error)
{
    return ss_report_csv_write(
        r->options->out, "scaling",
        "points,nodes,case,step_us_p50,step_us_p99,substeps,substep_us,paper_ms,jump_percent,"
        "ledger_fraction,active_nodes,field_error_direct,field_error_all_active,prototype_us,"
        "verdict,model,create_s,memory_mb,peak_mb,solver",
        r->row_count, put_row, r, error);
}

static void print_cell(int width, int digits, double value)
{
    if (isnan(value)) {
        printf(" %*s", width, "");
    } else {
        printf(" %*.*f", width, digits, value);
    }
}

static void print_small(int width, int digits, double value)
{
    if (isnan(value)) {
        printf(" %*s", width, "");
    } else {
        printf(" %*.*e", width, digits, value);
    }
}

static bool is_block(const ss_scaling_row *at)
{
    return strcmp(at->name, "block") == 0;
}

static bool has_solver(const ss_scaling_row *at, int32_t subject, const char *solver)
{
    return is_block(at) && strcmp(at->model, ss_stress_case_subject_name(subject)) == 0 &&
           strncmp(at->solver, solver, strlen(solver)) == 0;
}

/* Where the factor of a subject gives way, as a sentence; false: it solves no linear equations. */
static bool tell_solver(const ss_scaling *r, int32_t subject, char *out, size_t size)
{
    const ss_scaling_row *factored = NULL, *iterated = NULL; /* the largest, and the smallest */
    for (const ss_scaling_row *at = r->row; at < r->row + r->row_count; ++at) {
        factored = has_solver(at, subject, "a factor") ? at : factored;
        iterated = iterated == NULL && has_solver(at, subject, "conjugate") ? at : iterated;
    }
    const char *name = ss_stress_case_subject_name(subject);
    if (factored != NULL && iterated != NULL) {
        snprintf(out, size, "%s: factored up to %d nodes, from %d on %s.", name, factored->nodes,
                 iterated->nodes, iterated->solver);
    } else if (factored != NULL) {
        snprintf(out, size, "%s: factored at every size; at %d nodes %s.", name, factored->nodes,
                 factored->solver);
    } else if (iterated != NULL) {
        snprintf(out, size, "%s: %s.", name, iterated->solver);
    }
    return factored != NULL || iterated != NULL;
}

static void print_solvers(const ss_scaling *r)
{
    char text[512];
    for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
        if (tell_solver(r, s, text, sizeof text)) {
            printf("%s\n", text);
        }
    }
}

static void print_ellipsoids(const ss_scaling *r)
{
    printf("%6s %8s %7s %10s %10s %9s %9s %9s %9s %7s %10s %10s %9s  %s\n", "points", "case",
           "active", "p50 us", "p99 us", "sub-steps", "us each", "prototype", "paper ms", "jump %",
           "balance", "to direct", "to all", "verdict");
    for (int32_t i = 0; i < r->row_count; ++i) {
        const ss_scaling_row *at = &r->row[i];
        if (is_block(at)) {
            continue;
        }
        printf("%6d %8s %7d", at->points, at->name, at->active_nodes);
        print_cell(10, 1, at->p50_us);
        print_cell(10, 1, at->p99_us);
        print_cell(9, 2, at->substeps);
        print_cell(9, 1, at->p50_us / at->substeps);
        print_cell(9, 0, at->prototype_us);
        print_cell(9, 1, at->paper_ms);
        print_cell(7, 2, 100.0 * at->jump);
        print_small(10, 2, at->balance);
        print_small(10, 1, at->direct_error);
        print_small(9, 1, at->apart);
        printf("  %s\n", at->verdict);
    }
    printf("\n");
}

void ss_scaling_print(const ss_scaling *r)
{
    if (r->options->size_count > 0) {
        print_ellipsoids(r);
    }
    printf("%-24s %8s %9s %10s %10s %10s %12s %9s  %s\n", "block", "nodes", "create s", "memory MB",
           "peak MB", "p50 us", "ns a node", "sub-steps", "verdict");
    for (int32_t i = 0; i < r->row_count; ++i) {
        const ss_scaling_row *at = &r->row[i];
        if (is_block(at)) {
            printf("%-24s %8d", at->model, at->nodes > 0 ? at->nodes : at->points);
            print_cell(9, 2, at->create_s);
            print_cell(10, 1, at->memory_mb);
            print_cell(10, 1, at->peak_mb);
            print_cell(10, 1, at->p50_us);
            print_cell(12, 1, 1e3 * at->p50_us / at->substeps / at->nodes);
            print_cell(9, 2, at->substeps);
            printf("  %s\n", at->verdict);
        }
    }
    print_solvers(r);
}

/* A data block of one case, or of the paper with NULL. */
static void put_block(FILE *file, const char *block, const ss_scaling *r, const char *name)
{
    fprintf(file, "$%s << EOD\n", block);
    for (int32_t i = 0; i < r->row_count; ++i) {
        const ss_scaling_row *at = &r->row[i];
        if (name == NULL && strcmp(at->name, "load") == 0 && !isnan(at->paper_ms)) {
            fprintf(file, "%d %.6g\n", at->points, at->paper_ms);
        } else if (name != NULL && strcmp(at->name, name) == 0 && !isnan(at->p50_us)) {
            fprintf(file, "%d %.6g %.6g\n", at->nodes, 1e-3 * at->p50_us, 1e-3 * at->p99_us);
        }
    }
    fputs("EOD\n", file);
}

static softsim_status plot_times(const ss_scaling *r, ss_page *page, softsim_error *error)
{
    ss_output script;
    const softsim_status status = ss_plot_open(&script, r->options->out, "scaling", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    put_block(file, "load", r, "load");
    put_block(file, "slide", r, "slide");
    put_block(file, "paper", r, NULL);
    put_block(file, "all", r, "poke all");
    put_block(file, "poke", r, "poke");
    fprintf(file, "set logscale xy\nset grid\nset key outside right\nset xrange [%d:%d]\n",
            r->options->size[0] * 2 / 3, r->options->size[r->options->size_count - 1] * 3 / 2);
    fputs("set xlabel 'nodes'\nset ylabel 'ms of thread CPU for 1 ms of time'\n"
          "plot 1 with lines dt 3 lc rgb 'grey50' title 'real time', "
          "$paper using 1:2 with points pt 6 lw 2 lc rgb 'black' title 'paper, Table 1', "
          "$load using 1:2 with linespoints pt 7 lw 2 lc 1 title 'one loaded node', "
          "$slide using 1:2 with linespoints pt 5 lw 2 lc 2 title 'sliding sphere', "
          "$slide using 1:3 with lines dt 2 lc 2 title 'sliding sphere, p99', "
          "$all using 1:2 with linespoints pt 4 lw 2 lc 3 title 'local poke, all nodes', "
          "$poke using 1:2 with linespoints pt 9 lw 2 lc 4 title 'local poke, active set'\n",
          file);
    return ss_page_plot(page, &script, "scaling",
                        "Median step time against size. The paper's step is one of its own, on a "
                        "processor of 2005.",
                        error);
}

/* A picture of one figure of the blocks against nodes, a line a model. */
static softsim_status plot_blocks(const ss_scaling *r, bool is_memory, ss_page *page,
                                  softsim_error *error)
{
    ss_output script;
    const char *name = is_memory ? "scaling-memory" : "scaling-models";
    const softsim_status status = ss_plot_open(&script, r->options->out, name, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
        fprintf(file, "$m%d << EOD\n", s);
        for (int32_t i = 0; i < r->row_count; ++i) {
            const ss_scaling_row *at = &r->row[i];
            const double value = is_memory ? at->peak_mb : 1e-3 * at->p50_us;
            if (is_block(at) && strcmp(at->model, ss_stress_case_subject_name(s)) == 0 &&
                at->nodes > 0 && !isnan(value)) {
                fprintf(file, "%d %.6g\n", at->nodes, value);
            }
        }
        fputs("EOD\n", file);
    }
    fprintf(file,
            "set logscale xy\nset grid\nset key outside right\nset xlabel 'nodes'\n"
            "set ylabel '%s'\nplot ",
            is_memory ? "MB, largest, set-up included" : "ms of thread CPU for 1 ms of time");
    for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
        const char *name_of_model = ss_stress_case_subject_model(s);
        const ss_model_class *model = ss_accuracy_model_find(name_of_model);
        const bool is_second =
            s > 0 && strcmp(name_of_model, ss_stress_case_subject_model(s - 1)) == 0;
        fprintf(file,
                "%s$m%d using 1:2 with linespoints pt 7 ps 0.6 lw 2 dt %d lc rgb '%s' title '%s'",
                s > 0 ? ", " : "", s, is_second ? 2 : 1,
                model != NULL ? model->hints->colour : "black", ss_stress_case_subject_name(s));
    }
    fputc('\n', file);
    return ss_page_plot(page, &script, name,
                        is_memory ? "Peak memory of the block." : "The block, every model.", error);
}

static void put_blocks(ss_page *page, const ss_scaling *r)
{
    static const char *const head[] = {
        "model",        "nodes",   "create, CPU s", "memory, MB",
        "peak, MB",     "p50, us", "sub-steps",     "ns a node and sub-step",
        "active nodes", "balance", "verdict"};
    ss_page_table_begin(page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t i = 0; i < r->row_count; ++i) {
        const ss_scaling_row *at = &r->row[i];
        ss_row cells = {.count = 0};
        if (!is_block(at)) {
            continue;
        }
        ss_row_add(&cells, "%s", at->model);
        ss_row_add(&cells, "%d", at->nodes > 0 ? at->nodes : at->points);
        ss_row_add_number(&cells, at->create_s);
        ss_row_add_number(&cells, at->memory_mb);
        ss_row_add_number(&cells, at->peak_mb);
        ss_row_add_number(&cells, at->p50_us);
        ss_row_add_number(&cells, at->substeps);
        ss_row_add_number(&cells, 1e3 * at->p50_us / at->substeps / at->nodes);
        ss_row_add(&cells, "%d", at->active_nodes);
        ss_row_add_number(&cells, at->balance);
        ss_row_add(&cells, "%s", at->verdict);
        ss_page_table_row(page, cells.count, cells.cell);
    }
    ss_page_table_end(page);
}

static void put_table(ss_page *page, const ss_scaling *r)
{
    static const char *const head[] = {"points",
                                       "case",
                                       "active nodes",
                                       "p50, us",
                                       "p99, us",
                                       "model step alone, us",
                                       "sub-steps",
                                       "us a sub-step",
                                       "prototype, us",
                                       "paper, ms",
                                       "jump, %",
                                       "mean force, N",
                                       "balance",
                                       "field error against a direct solve",
                                       "field error against all nodes active",
                                       "verdict"};
    ss_page_table_begin(page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t i = 0; i < r->row_count; ++i) {
        const ss_scaling_row *at = &r->row[i];
        ss_row cells = {.count = 0};
        if (is_block(at)) {
            continue;
        }
        ss_row_add(&cells, "%d", at->points);
        ss_row_add(&cells, "%s", at->name);
        ss_row_add(&cells, "%d", at->active_nodes);
        ss_row_add_number(&cells, at->p50_us);
        ss_row_add_number(&cells, at->p99_us);
        ss_row_add_number(&cells, at->step_us);
        ss_row_add_number(&cells, at->substeps);
        ss_row_add_number(&cells, at->p50_us / at->substeps);
        ss_row_add_number(&cells, at->prototype_us);
        ss_row_add_number(&cells, at->paper_ms);
        ss_row_add_number(&cells, 100.0 * at->jump);
        ss_row_add_number(&cells, at->mean_force);
        ss_row_add_number(&cells, at->balance);
        ss_row_add_number(&cells, at->direct_error);
        ss_row_add_number(&cells, at->apart);
        ss_row_add(&cells, "%s", at->verdict);
        ss_page_table_row(page, cells.count, cells.cell);
    }
    ss_page_table_end(page);
}

static softsim_status put_ellipsoids(ss_page *page, const ss_scaling *r, softsim_error *error)
{
    ss_page_text(
        page,
        "An ellipsoid of 100 x 60 x 60 mm, held below, cnn-energy, one thread, steps "
        "of 1 ms (sub-steps inside where stability needs them). load: 0.2 N on one "
        "node, no tool, all nodes active. slide: a sphere of 5 mm pressed 6 mm deep, moved 30 "
        "mm at 50 mm/s, released. poke: the same ellipsoid, larger, so that its edges are 4 "
        "mm long at every size, pretension 0.05 J; 0.1 N on the nodes within 10 mm of the "
        "top; with all nodes active (poke all), and with the active set. pull: 0.5 N "
        "upwards on the body of poke, all nodes active.");
    const softsim_status status = plot_times(r, page, error);
    put_table(page, r);
    ss_page_text(page, "p50, p99: thread CPU time of whole ticks (model step, contact and haptic "
                       "tick) while loaded or sliding; beside it the median of the model's step "
                       "with its contact over the whole run. Jump: largest change between two "
                       "consecutive 1 kHz forces over the mean force while sliding at constant "
                       "speed. Ledger: (elastic + kinetic + dissipated - work) at the end over the "
                       "largest stored energy; the slide ends free and at rest, the load still "
                       "loaded. Prototype: a Runge-Kutta step of the first "
                       "program that tried this model, one core of another machine, all nodes.");
    ss_page_text(
        page,
        "Field error: the largest distance between the model's displacements and others, over "
        "the largest of these. Against a direct solve: the equilibrium of the same body under "
        "the same load, assembled again from the mesh in double and solved with sparse factors "
        "of its own, potentials and shape, their residuals checked; of load, pull and poke at the "
        "end of the run, of slide when the sphere, pressed in, has stood still for half a "
        "second. There the direct solve is given the displacements of what the sphere touches "
        "and of the neighbours, and finds all others: it does not judge the contact itself. "
        "Nor does it judge how far a field in motion is from its equilibrium. Where the round "
        "surface is pressed in it shortens before it stretches, and the network answers by its "
        "pretension alone: pull is the row in which the modulus acts at every size. Against all "
        "nodes active: the field of poke against that of poke all, what the active set "
        "costs. A refused case has no field; where the direct solve fails, the verdict says why.");
    return status;
}

softsim_status ss_scaling_write_page(const ss_scaling *r, softsim_error *error)
{
    ss_page page;
    char text[512];
    softsim_status status =
        ss_page_open(&page, r->options->out, "scaling", "softsim: scaling", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    if (r->options->size_count > 0) {
        status = put_ellipsoids(&page, r, error);
    }
    ss_page_heading(&page, "Every model");
    ss_page_text(
        &page,
        "A cube of 100 mm of 10 kPa in tetrahedra (its surface for a model that lives "
        "there), held below, one node of the top pushed (chainmail, which keeps its shape: "
        "moved by an edge in the course of the run); ticks of 1 ms, at most %d of "
        "them. A process each: peak memory is the whole of it, with reading the mesh and "
        "the factors; create is the CPU time of all that comes before the first tick. "
        "Where the sparse factor of cnn-energy would take more multiplications than it allows, "
        "or have more entries than an int counts, conjugate gradients find the columns "
        "(below: where); tools, which need all columns, are refused by name long before. "
        "No field error stands beside these: a direct solve is made for the ellipsoids of "
        "cnn-energy alone, which end at %d points; softsim-bench accuracy compares the fields of "
        "all models with references.",
        200, SS_SCALING_LARGEST_ELLIPSOID);
    for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
        if (tell_solver(r, s, text, sizeof text)) {
            ss_page_text(&page, "%s", text);
        }
    }
    put_blocks(&page, r);
    if (status == SOFTSIM_OK) {
        status = plot_blocks(r, false, &page, error);
    }
    if (status == SOFTSIM_OK) {
        status = plot_blocks(r, true, &page, error);
    }
    ss_page_heading(&page, "Elements");
    ss_page_text(&page, "What an element and sub-step take, integration included, on an ellipsoid "
                        "of 50, 35 and 25 mm half axes that swings; flops and bytes as the model "
                        "states them, over what this processor does of them in this run.");
    ss_scaling_put_elements(&page, r);
    ss_page_yardstick(&page, &r->yardstick);
    if (status == SOFTSIM_OK) {
        status = ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}
