/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/stability/stability.h"
/*
 * What came of the runs: stability.csv, one map a kind (a row of it is a model at a stiffness or
 * variant, a column a value), and the page with the table of guards that acted.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/report.h"
#include "bench/stability/audit.h"
#include "bench/stability/stress_scene.h"
#include "output.h"
#include "rt/memory.h"

enum { MAX_LINES = 1024, MAX_COLUMNS = 16, MAX_GUARDS = 512, MAX_FAILURES = 200 };
enum { MAP_WIDTH = 900, LINE_HEIGHT = 15, MAP_MARGIN = 180 };

/* How a run is told: colours of the map and columns of the summary. */
typedef enum fate { STABLE, GUARDED, DEGRADED, REFUSED, DIVERGED, FAILED, FATES } fate;
static const struct {
    const char *name;
    int colour;
} fates[FATES] = {
    {"stable", 0x4daf4a},  {"guarded, trusted", 0xffe066}, {"guarded, degraded", 0xff8c1a},
    {"refused", 0xbbbbbb}, {"diverged, said", 0xe41a1c},   {"failure", 0x000000}};

static fate fate_of(const ss_stability_row *row)
{
    return row->is_lost || !row->is_agreed            ? FAILED
           : row->outcome == SS_STRESS_CASE_STABLE    ? STABLE
           : row->outcome == SS_STRESS_CASE_REFUSED   ? REFUSED
           : row->outcome == SS_STRESS_CASE_DIVERGED  ? DIVERGED
           : row->verdict >= SOFTSIM_VERDICT_DEGRADED ? DEGRADED
                                                      : GUARDED;
}

/* ---- CSV ---- */

static const char csv_head[] =
    "model,sweep,stiffness_pa,value,variant,outcome,verdict,acted,found,agrees,limit_s,step_s,"
    "ticks,substeps,stored_j,end_j,balance_error,work_error,displacement_m,recovery_error,"
    "kinetic_j,handed_out_j,made_j,driven_j,force_n,depth_m,inverted,cpu_ms";

static softsim_status write_csv(const ss_stability *list, const ss_sweep_result *result,
                                softsim_error *error)
{
    ss_output output;
    const softsim_status status =
        ss_report_csv_open(&output, list->folder, "stability", csv_head, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < list->count; ++i) {
        ss_stability_row row;
        char label[SS_SWEEP_NAME_SIZE];
        ss_stability_read(result, i, &row);
        if (row.is_lost) {
            ss_stability_label(list, i, label);
            fprintf(output.file, "%s,lost,,", label);
            ss_csv_text(output.file, row.acted);
            fputs(",,no,,,,,,,,,,,,,,,,,,\n", output.file);
        } else {
            fputs(row.csv, output.file);
        }
    }
    return ss_output_commit(&output, error);
}

/* ---- maps ---- */

/* Where a kind has one value and several variants, those are the columns. */
typedef struct map {
    bool is_by_variant, has_variants;
    struct {
        int32_t subject, variant;
        double stiffness;
    } line[MAX_LINES];
    double column[MAX_COLUMNS];
    int32_t line_count, column_count;
} map;

static int32_t find_line(map *m, const ss_stress_case *trial)
{
    const double stiffness = trial->kind == SS_STRESS_CASE_STIFFNESS ? 0.0 : trial->stiffness_pa;
    for (int32_t i = 0; i < m->line_count; ++i) {
        if (m->line[i].subject == trial->subject && m->line[i].stiffness == stiffness &&
            (m->is_by_variant || m->line[i].variant == trial->variant)) {
            return i;
        }
    }
    if (m->line_count == MAX_LINES) {
        return -1;
    }
    m->line[m->line_count].subject = trial->subject;
    m->line[m->line_count].variant = trial->variant;
    m->line[m->line_count].stiffness = stiffness;
    return m->line_count++;
}

static int32_t find_column(map *m, double value)
{
    for (int32_t i = 0; i < m->column_count; ++i) {
        if (m->column[i] == value) {
            return i;
        }
    }
    if (m->column_count == MAX_COLUMNS) {
        return -1;
    }
    m->column[m->column_count] = value;
    return m->column_count++;
}

static void choose_columns(const ss_stability *list, ss_stress_case_kind kind, map *m)
{
    const ss_stress_case *first = NULL;
    bool has_values = false;
    m->has_variants = false;
    for (int32_t i = 0; i < list->count; ++i) {
        const ss_stress_case *trial = &list->trial[i];
        if (trial->kind == kind) {
            first = first != NULL ? first : trial;
            has_values |= trial->value != first->value;
            m->has_variants |= trial->variant != first->variant;
        }
    }
    m->is_by_variant = !has_values && m->has_variants;
}

/* The places of all runs of a kind; `file`: also where they are and their colours. */
static void lay_map(const ss_stability *list, const ss_sweep_result *result,
                    ss_stress_case_kind kind, map *m, FILE *file)
{
    for (int32_t i = 0; i < list->count; ++i) {
        if (list->trial[i].kind != kind) {
            continue;
        }
        const int32_t line = find_line(m, &list->trial[i]);
        const int32_t column =
            find_column(m, m->is_by_variant ? list->trial[i].variant : list->trial[i].value);
        if (file != NULL && line >= 0 && column >= 0) {
            ss_stability_row row;
            ss_stability_read(result, i, &row);
            fprintf(file, "%d %d %d\n", column, line, fates[fate_of(&row)].colour);
        }
    }
}

static void put_tics(const map *m, FILE *file)
{
    fputs("set xtics (", file);
    for (int32_t i = 0; i < m->column_count; ++i) {
        fprintf(file, "%s'%g' %d", i > 0 ? ", " : "", m->column[i], i);
    }
    fputs(")\nset ytics (", file);
    for (int32_t i = 0; i < m->line_count; ++i) {
        fprintf(file, "%s'%s", i > 0 ? ", " : "", ss_stress_case_subject_name(m->line[i].subject));
        if (m->line[i].stiffness > 0.0) {
            fprintf(file, ", %.0e Pa", m->line[i].stiffness);
        }
        if (m->has_variants && !m->is_by_variant) {
            fprintf(file, ", %d", m->line[i].variant);
        }
        fprintf(file, "' %d", i);
    }
    fputs(")\n", file);
}

static softsim_status plot_map(const ss_stability *list, const ss_sweep_result *result,
                               ss_stress_case_kind kind, ss_page *page, softsim_error *error)
{
    static map m; /* large */
    char name[64];
    ss_output script;
    m.line_count = m.column_count = 0;
    choose_columns(list, kind, &m);
    lay_map(list, result, kind, &m, NULL);
    if (m.line_count == 0) {
        return SOFTSIM_OK;
    }
    snprintf(name, sizeof name, "stability-%s", ss_stress_case_kind_name(kind));
    const softsim_status status = ss_plot_open_sized(
        &script, list->folder, name, MAP_WIDTH, MAP_MARGIN + LINE_HEIGHT * m.line_count, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    fputs("$map << EOD\n", file);
    lay_map(list, result, kind, &m, file);
    fputs("EOD\n", file);
    put_tics(&m, file);
    fprintf(file,
            "set termoption noenhanced\nset tmargin 5\nset xrange [-0.5:%g]\nset yrange [-0.5:%g]\n"
            "set xlabel \"%s\"\nset tics out nomirror font ',10'\n"
            "set key outside top center horizontal height 1 samplen 2 font ',10'\nplot ",
            m.column_count - 0.5, m.line_count - 0.5, ss_stress_case_value_name(kind));
    for (int f = 0; f < FATES; ++f) {
        fprintf(file, "keyentry with boxes fs solid 1 lc rgb 0x%06x title '%s', ", fates[f].colour,
                fates[f].name);
    }
    fputs("$map using 1:2:(0.47):(0.44):3 with boxxyerror fs solid 1 noborder lc rgb variable "
          "notitle\n",
          file);
    return ss_page_plot(page, &script, name, ss_stress_case_kind_name(kind), error);
}

/* ---- tables ---- */

static void count_fates(const ss_stability *list, const ss_sweep_result *result, int32_t subject,
                        int32_t out_count[FATES])
{
    memset(out_count, 0, FATES * sizeof *out_count);
    for (int32_t i = 0; i < list->count; ++i) {
        ss_stability_row row;
        ss_stability_read(result, i, &row);
        if (subject < 0 || list->trial[i].subject == subject) {
            ++out_count[fate_of(&row)];
        }
    }
}

static void put_summary(const ss_stability *list, const ss_sweep_result *result, ss_page *page)
{
    const char *head[FATES + 1] = {"model"};
    for (int f = 0; f < FATES; ++f) {
        head[f + 1] = fates[f].name;
    }
    ss_page_table_begin(page, FATES + 1, head);
    for (int32_t s = -1; s < ss_stress_case_subject_count(); ++s) {
        int32_t count[FATES], all = 0;
        ss_row cells = {.count = 0};
        count_fates(list, result, s, count);
        ss_row_add(&cells, "%s", s < 0 ? "all" : ss_stress_case_subject_name(s));
        for (int f = 0; f < FATES; ++f) {
            ss_row_add(&cells, "%d", count[f]);
            all += count[f];
        }
        if (all > 0) {
            ss_page_table_row(page, cells.count, cells.cell);
        }
    }
    ss_page_table_end(page);
}

/* What acted, for a model and a kind. */
typedef struct guard {
    int32_t subject, count;
    ss_stress_case_kind kind;
    ss_stability_row row;
} guard;

static int32_t collect_guards(const ss_stability *list, const ss_sweep_result *result, guard *out)
{
    int32_t count = 0;
    for (int32_t i = 0; i < list->count; ++i) {
        ss_stability_row row;
        int32_t at = 0;
        ss_stability_read(result, i, &row);
        while (at < count &&
               (out[at].subject != list->trial[i].subject || out[at].kind != list->trial[i].kind ||
                fate_of(&out[at].row) != fate_of(&row) ||
                strcmp(out[at].row.acted, row.acted) != 0)) {
            ++at;
        }
        if (row.acted[0] == '\0' || at == MAX_GUARDS) {
            continue;
        }
        if (at == count) {
            out[count++] = (guard){list->trial[i].subject, 0, list->trial[i].kind, row};
        }
        ++out[at].count;
    }
    return count;
}

static softsim_status put_guards(const ss_stability *list, const ss_sweep_result *result,
                                 ss_page *page, softsim_error *error)
{
    static const char *const head[] = {"model", "sweep", "runs", "outcome", "what acted"};
    guard *guards = calloc(MAX_GUARDS, sizeof *guards);
    if (guards == NULL) {
        return ss_memory_fault(error);
    }
    const int32_t count = collect_guards(list, result, guards);
    ss_page_table_begin(page, (int32_t)(sizeof head / sizeof *head), head);
    for (int32_t i = 0; i < count; ++i) {
        ss_row cells = {.count = 0};
        ss_row_add(&cells, "%s", ss_stress_case_subject_name(guards[i].subject));
        ss_row_add(&cells, "%s", ss_stress_case_kind_name(guards[i].kind));
        ss_row_add(&cells, "%d", guards[i].count);
        ss_row_add(&cells, "%s", fates[fate_of(&guards[i].row)].name);
        ss_row_add(&cells, "%s", guards[i].row.acted);
        ss_page_table_row(page, cells.count, cells.cell);
    }
    ss_page_table_end(page);
    free(guards);
    return SOFTSIM_OK;
}

/* A failure in words. */
static void describe(const ss_stability *list, const ss_stability_row *row, int32_t index,
                     char *out, size_t size)
{
    char label[SS_SWEEP_NAME_SIZE], found[192];
    ss_stability_label(list, index, label);
    ss_audit_text(row->found, found, (int32_t)sizeof found);
    snprintf(out, size, "%s: %s%s%s%s", label,
             row->is_lost       ? "lost"
             : found[0] != '\0' ? "found: "
                                : "what must be stable is not",
             found, row->is_lost || row->acted[0] != '\0' ? "; the program said: " : "",
             row->acted);
}

static void put_failures(const ss_stability *list, const ss_sweep_result *result, ss_page *page)
{
    static const char *const head[] = {"run", "failure"};
    ss_page_table_begin(page, 2, head);
    for (int32_t i = 0, shown = 0; i < list->count && shown < MAX_FAILURES; ++i) {
        ss_stability_row row;
        char text[1024];
        ss_stability_read(result, i, &row);
        if (fate_of(&row) == FAILED) {
            ss_row cells = {.count = 0};
            describe(list, &row, i, text, sizeof text);
            ss_row_add(&cells, "%d", i);
            ss_row_add(&cells, "%s", text);
            ss_page_table_row(page, cells.count, cells.cell);
            ++shown;
        }
    }
    ss_page_table_end(page);
}

/* ---- the page ---- */

static void put_words(const ss_stability *list, ss_page *page)
{
    ss_page_text(
        page,
        "%d runs of a rounded cube of 100 mm, 125 nodes, 384 tetrahedra, held below, as scenes "
        "through the product's own loader, checks and haptic tick. Every run is judged twice: by "
        "the program (its worst verdict of all steps), and from outside by what it publishes "
        "alone: is all of it finite, is no node further away than the load explains, does the "
        "energy add up within 5 %% of the largest, does the published work agree with F.du, does "
        "nothing grow after release, is the body back within 10 %% of its largest displacement. "
        "A verdict of good or guarded promises a result to be trusted; with one finding against "
        "it the run is a failure (but guards may take energy out, and leave a body in another "
        "shape). Degraded and fault declare the result untrusted; such a run fails only if a "
        "published value is not finite. Control "
        "runs must have no finding, and be good or guarded; none is refused but loads by a model "
        "without forces.",
        list->count);
    ss_page_text(
        page, "A start cannot be set in a scene. Tangled: random forces on half of the surface's "
              "nodes from the first step on, let go at four time constants (variants 0 to 2), or "
              "these at random prescribed places in one step (3 to 5). Flattened: "
              "a force on the top (0), or the top prescribed to a share of the height, below 0 "
              "through the bottom (1). Teleport: a pressing tool (0), the same with jumps of "
              "up to 10 m accepted (1), the top prescribed (2). Control and stiffness: load "
              "(0), probe (1), prescribed top (2).");
    ss_page_text(page,
                 "Contradictions: 0 everything fixed and pushed; 1 fixed nodes put elsewhere; 2 "
                 "two places for one node; 3 a load on fixed nodes; 4 a load on prescribed "
                 "nodes; 5 every node prescribed; 6 two sets for different axes (no "
                 "contradiction); 7 two sets "
                 "for one axis; 8 a tool inside the body from the start; 9 a tool pushed through "
                 "the fixed bottom; 10 a body held by one node.");
    ss_page_text(page,
                 "Abuse of a tool in a press of 5 mm: noise on every position; in and out, up to "
                 "half the rate of the loop; through the body and back (0, and with jumps of up to "
                 "10 m accepted, 1), from side to side (2); a box that spins upright (0) or end "
                 "over end (1); pause and resume in turn. The hand is judged from poses and "
                 "forces, and from what the program says it stored, where its proxy was and when "
                 "it let a tool in (flag 8). A contact may give the hand at most 10 mJ under "
                 "verdict good, and 100 mJ under guarded. The force is applied at once or one "
                 "pose later; the worse case counts. Under good, a part of a contact may also "
                 "give at most 10 mJ more than was stored at its beginning; under guarded, the "
                 "energy with which a tool found inside was let in is not counted. No force may "
                 "exceed the limit of %g N and no depth the body's size.",
                 SS_STRESS_CASE_MAX_FORCE);
}

static softsim_status write_page(const ss_stability *list, const ss_sweep_result *result,
                                 const ss_yardstick *yardstick, softsim_error *error)
{
    ss_page page;
    softsim_status status =
        ss_page_open(&page, list->folder, "stability", "softsim: stability", error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    put_words(list, &page);
    put_summary(list, result, &page);
    ss_page_heading(&page, "Failures");
    put_failures(list, result, &page);
    ss_page_heading(&page, "Guards that acted, and refusals");
    status = put_guards(list, result, &page, error);
    ss_page_heading(&page, "Maps");
    for (int k = 0; status == SOFTSIM_OK && k < SS_STRESS_CASE_KINDS; ++k) {
        status = plot_map(list, result, (ss_stress_case_kind)k, &page, error);
    }
    ss_page_link(&page, "stability.csv");
    ss_page_yardstick(&page, yardstick);
    if (status == SOFTSIM_OK) {
        status = ss_page_close(&page, error);
    }
    ss_page_abandon(&page);
    return status;
}

softsim_status ss_stability_report(const ss_stability *list, const ss_sweep_result *result,
                                   const ss_yardstick *yardstick, softsim_error *error)
{
    const softsim_status status = write_csv(list, result, error);
    return status == SOFTSIM_OK ? write_page(list, result, yardstick, error) : status;
}

int32_t ss_stability_print(const ss_stability *list, const ss_sweep_result *result)
{
    int32_t count[FATES], shown = 0;
    for (int32_t i = 0; i < list->count; ++i) {
        ss_stability_row row;
        char text[1024];
        ss_stability_read(result, i, &row);
        if (fate_of(&row) == FAILED && shown++ < MAX_FAILURES) {
            describe(list, &row, i, text, sizeof text);
            printf("FAIL %s\n", text);
        }
    }
    for (int32_t s = -1; s < ss_stress_case_subject_count(); ++s) {
        count_fates(list, result, s, count);
        int32_t all = 0;
        for (int f = 0; f < FATES; ++f) {
            all += count[f];
        }
        if (all > 0) {
            printf("%-24s %5d runs: %d stable, %d guarded, %d degraded, %d refused, %d diverged "
                   "and said so, %d failures\n",
                   s < 0 ? "all" : ss_stress_case_subject_name(s), all, count[STABLE],
                   count[GUARDED], count[DEGRADED], count[REFUSED], count[DIVERGED], count[FAILED]);
        }
    }
    count_fates(list, result, -1, count);
    return count[FAILED];
}
