/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The stability report: its body is a mesh at every flatness; the audit finds each way in which
 * what is published can be wrong, and nothing in what is right; a verdict agrees with it exactly
 * when it declares what was found; every run is listed once; and runs of the models that are built
 * in end as they must.
 */
#include "common/test.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/stability/audit.h"
#include "bench/stability/specimen.h"
#include "bench/stability/stability.h"
#include "bench/stability/stress_case.h"
#include "common/folder_fixture.h"
#include "models/model.h"
#include "rt/vec.h"

/* ---- the body ---- */

static double volume_of(const ss_specimen *s, int32_t t)
{
    double edge[3][3], normal[3];
    for (int c = 0; c < 3; ++c) {
        ss_sub3(edge[c], s->rest[s->tetrahedron[t][c + 1]], s->rest[s->tetrahedron[t][0]]);
    }
    ss_cross3(normal, edge[0], edge[1]);
    return ss_dot3(normal, edge[2]) / 6.0;
}

TEST(the_specimen_is_a_mesh_at_every_flatness)
{
    static ss_specimen s;
    double whole = 0.0, regular = 1.0;
    for (double flatness = 1.0; flatness > 5e-7; flatness *= 0.1) {
        double sum = 0.0, least = 1.0;
        ss_specimen_make(flatness, &s);
        for (int32_t t = 0; t < SS_SPECIMEN_TETRAHEDRA; ++t) {
            sum += volume_of(&s, t);
            least = fmin(least, volume_of(&s, t));
        }
        whole = flatness == 1.0 ? sum : whole;
        regular = flatness == 1.0 ? least : regular;
        assert_true(least > 0.0);
        assert_true(least < 2.0 * flatness * regular / (flatness < 1.0 ? 0.2 : 1.0));
        assert_true(fabs(sum - whole) < 0.01 * whole); /* only the top's node changes it */
    }
    int32_t surface = 0;
    for (int32_t i = 0; i < SS_SPECIMEN_NODES; ++i) {
        surface += ss_specimen_is_surface(i);
    }
    assert_int_equal(surface, 98);
}

TEST(inverted_elements_are_counted)
{
    static ss_specimen s;
    static double u[SS_SPECIMEN_NODES][3];
    ss_specimen_make(1.0, &s);
    assert_int_equal(ss_specimen_inverted(&s, (const double(*)[3])u), 0);
    for (int32_t i = 0; i < SS_SPECIMEN_NODES; ++i) {
        u[i][2] = -2.0 * s.rest[i][2]; /* a mirror */
    }
    assert_int_equal(ss_specimen_inverted(&s, (const double(*)[3])u), SS_SPECIMEN_TETRAHEDRA);
}

/* ---- the audit ---- */

enum { STEPS = 40, RELEASE = 20 };

/* A spring of 2 N/m pushed to 1 m and let go, with heavy damping; what `defect` says is wrong. */
typedef enum defect {
    NONE,
    BAD_NUMBER,
    BAD_FORCE,
    RUNS_AWAY,
    MAKES_ENERGY,
    LOSES_ENERGY,
    WRONG_WORK,
    GROWS_LATER,
    STAYS
} defect;

static uint32_t audit_spring(defect what, bool has_work, bool is_rested)
{
    static const ss_audit_plan plan = {.reach = 2.0, .floor = 1e-9, .has_work = true};
    ss_audit audit;
    ss_audit_plan own = plan;
    double work = 0.0, dissipated = 0.0, before = 0.0;
    own.has_work = has_work;
    ss_audit_begin(&audit, &own);
    for (int k = 0; k <= STEPS; ++k) {
        const bool is_released = k > RELEASE;
        double x = is_released ? exp(-0.5 * (k - RELEASE)) : (double)k / RELEASE;
        x = what == STAYS && is_released ? 0.5 : x;
        x = what == RUNS_AWAY && k == RELEASE ? 3.0 : x;
        const double elastic = x * x;
        const double applied = is_released ? 0.0 : 2.0 * (x - before);
        work += what == WRONG_WORK ? -applied : applied;
        dissipated += applied - (elastic - before * before);
        ss_audit_sample sample = {.count = 1,
                                  .elastic = elastic,
                                  .dissipated = dissipated,
                                  .work = work,
                                  .applied = applied,
                                  .is_released = is_released};
        sample.elastic += what == MAKES_ENERGY && k == 10 ? 0.2 : 0.0;
        sample.elastic -= what == LOSES_ENERGY && k == 10 ? 0.2 : 0.0;
        sample.elastic += what == GROWS_LATER && k == STEPS ? 1.5 : 0.0;
        sample.work += what == GROWS_LATER && k == STEPS ? 1.5 : 0.0;
        sample.dissipated = what == WRONG_WORK ? sample.work - sample.elastic : sample.dissipated;
        sample.force[1] = what == BAD_FORCE && k == 7 ? (double)INFINITY : 0.0;
        const double u[1][3] = {{0.0, x, 0.0}};
        const double v[1][3] = {{0.0, what == BAD_NUMBER && k == 5 ? (double)NAN : 0.0, 0.0}};
        sample.displacement = u;
        sample.velocity = v;
        ss_audit_look(&audit, &sample);
        before = x;
    }
    return ss_audit_end(&audit, is_rested);
}

TEST(the_audit_finds_what_is_wrong_and_nothing_else)
{
    static const struct {
        defect what;
        uint32_t found;
    } rows[] = {{NONE, 0},
                {BAD_NUMBER, SS_AUDIT_NOT_FINITE},
                {BAD_FORCE, SS_AUDIT_NOT_FINITE},
                {RUNS_AWAY, SS_AUDIT_FAR},
                {MAKES_ENERGY, SS_AUDIT_GAIN},
                {LOSES_ENERGY, SS_AUDIT_LOSS},
                {WRONG_WORK, SS_AUDIT_WORK},
                {STAYS, SS_AUDIT_NOT_BACK}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
        assert_int_equal(audit_spring(rows[k].what, true, true), rows[k].found);
    }
    /* Work that nobody did is both. */
    assert_int_equal(audit_spring(GROWS_LATER, true, true), SS_AUDIT_GROWS | SS_AUDIT_WORK);
    assert_int_equal(audit_spring(GROWS_LATER, false, true), SS_AUDIT_GROWS);
    /* A body that had no time is not asked to be back. */
    assert_int_equal(audit_spring(STAYS, true, false), 0);
}

TEST(a_verdict_agrees_when_it_owns_up)
{
    assert_true(ss_audit_agrees(0, SOFTSIM_VERDICT_GOOD));
    assert_true(ss_audit_agrees(0, SOFTSIM_VERDICT_FAULT));
    for (int k = 0; k < SS_AUDIT_KINDS; ++k) {
        const uint32_t found = 1u << k;
        const bool is_mild =
            found == SS_AUDIT_NOT_BACK || found == SS_AUDIT_LOSS || found == SS_AUDIT_HANDED_OUT;
        const bool is_hopeless = found == SS_AUDIT_NOT_FINITE;
        char text[192], before[192];
        assert_false(ss_audit_agrees(found, SOFTSIM_VERDICT_GOOD));
        assert_int_equal(ss_audit_agrees(found, SOFTSIM_VERDICT_GUARDED), is_mild);
        assert_int_equal(ss_audit_agrees(found, SOFTSIM_VERDICT_DEGRADED), !is_hopeless);
        assert_int_equal(ss_audit_agrees(found, SOFTSIM_VERDICT_FAULT), !is_hopeless);
        ss_audit_text(found, text, sizeof text);
        ss_audit_text(found >> 1, before, sizeof before);
        assert_true(text[0] != '\0' && text[0] != '(');
        assert_string_not_equal(text, before);
    }
}

/* ---- the list ---- */

static int compare_text(const void *a, const void *b)
{
    return strcmp(a, b);
}

TEST(every_model_of_the_program_is_tried)
{
    int32_t models = 0;
    const ss_model_class *const *table = ss_model_table(&models);
    for (int32_t m = 0; m < models; ++m) {
        bool is_found = false;
        for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
            is_found = is_found || strcmp(ss_stress_case_subject_model(s), table[m]->name) == 0;
        }
        assert_true(is_found);
    }
}

TEST(every_run_is_listed_once)
{
    static const char *const all[] = {NULL};
    ss_stability list, quick;
    assert_true(ss_stability_list(&list, all, false));
    assert_true(ss_stability_list(&quick, all, true));
    assert_true(list.count >= 200 * ss_stress_case_subject_count());
    assert_in_range(4 * quick.count, list.count * 9 / 10, list.count * 11 / 10); /* --help */
    char(*label)[SS_SWEEP_NAME_SIZE] = calloc((size_t)list.count, sizeof *label);
    assert_non_null(label);
    for (int32_t i = 0; i < list.count; ++i) {
        ss_stability_label(&list, i, label[i]);
    }
    qsort(label, (size_t)list.count, sizeof *label, compare_text);
    for (int32_t i = 1; i < list.count; ++i) {
        assert_string_not_equal(label[i - 1], label[i]);
    }
    free(label);
    ss_stability_list_fini(&list);
    ss_stability_list_fini(&quick);
}

TEST(what_a_run_leaves_is_read_back)
{
    char good[] = "1 2 9 0 3\nwhat acted\na,b,c\n", silent[] = "0 0 0 1 0\n\nd,e\n";
    char lost[] = "crashed: Killed";
    ss_sweep_run run[] = {{false, good}, {false, silent}, {true, lost}};
    const ss_sweep_result result = {.is_complete = true, .count = 3, .run = run};
    ss_stability_row row;
    ss_stability_read(&result, 0, &row);
    assert_int_equal(row.outcome, SS_STRESS_CASE_GUARDED);
    assert_int_equal(row.verdict, SOFTSIM_VERDICT_DEGRADED);
    assert_int_equal(row.found, 9);
    assert_false(row.is_agreed);
    assert_int_equal(row.inverted, 3);
    assert_string_equal(row.acted, "what acted");
    assert_string_equal(row.csv, "a,b,c\n");
    ss_stability_read(&result, 1, &row);
    assert_true(row.is_agreed);
    assert_string_equal(row.acted, "");
    assert_string_equal(row.csv, "d,e\n");
    ss_stability_read(&result, 2, &row);
    assert_true(row.is_lost);
    assert_false(row.is_agreed);
    assert_string_equal(row.acted, "crashed: Killed");
}

/* ---- runs ---- */

static ss_stress_case_result run_of(int32_t subject, ss_stress_case_kind kind, double stiffness_pa,
                                    double value, int32_t variant)
{
    const ss_stress_case stress_case = {subject, kind, stiffness_pa, value, variant};
    ss_stress_case_result result;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_stress_case_run(&stress_case, folder, &result, &error), SOFTSIM_OK);
    return result;
}

TEST(a_light_load_is_stable_and_its_work_adds_up)
{
    for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
        const ss_stress_case_result r = run_of(s, SS_STRESS_CASE_CONTROL, 1e4, 0.0, 0);
        if (!r.is_agreed) {
            fail_msg("%s: found %u, %s", ss_stress_case_subject_name(s), r.found, r.acted);
        }
        /* There is no force in a chain, and it says so. */
        assert_true(ss_stress_case_is_plastic(s) ? r.outcome == SS_STRESS_CASE_REFUSED
                                                 : r.recovery < 0.1);
    }
}

/* A report whose controls are all refused has shown nothing. */
TEST(what_must_be_stable_may_not_be_refused)
{
    const ss_stress_case_result r = run_of(0, SS_STRESS_CASE_CONTROL, 1e40, 0.0, 0);
    assert_int_equal(r.outcome, SS_STRESS_CASE_REFUSED);
    assert_false(r.is_agreed);
}

/* What a body does does not depend on its stiffness, hence neither does what is said of it. */
TEST(a_soft_body_owns_up_as_a_stiff_one_does)
{
    for (double stiffness = 1.0; stiffness < 1e5; stiffness *= 1e2) {
        assert_true(run_of(0, SS_STRESS_CASE_STEP, stiffness, 2.0, 0).is_agreed);
    }
}

/* What is let go is watched until it can be back, also where a model's time is its own. */
TEST(the_stiffest_body_is_back_when_it_is_asked_to_be)
{
    for (int32_t s = 0; s < ss_stress_case_subject_count(); ++s) {
        const ss_stress_case_result r = run_of(s, SS_STRESS_CASE_STEP, 1e9, 0.5, 0);
        if (!r.is_agreed) {
            fail_msg("%s: found %u, %g of it is left", ss_stress_case_subject_name(s), r.found,
                     r.recovery);
        }
    }
}

TEST(contradictions_are_refused_by_name)
{
    const ss_stress_case_result r = run_of(0, SS_STRESS_CASE_CONTRADICTION, 1e4, 0.0, 2);
    assert_int_equal(r.outcome, SS_STRESS_CASE_REFUSED);
    assert_non_null(strstr(r.acted, "prescribed.1 holds node 112"));
    assert_null(strstr(r.acted, folder));
}

TEST(a_teleport_is_refused_by_the_gate_and_said)
{
    const ss_stress_case_result r = run_of(0, SS_STRESS_CASE_TELEPORT, 1e6, 1.0, 0);
    assert_int_equal(r.outcome, SS_STRESS_CASE_GUARDED);
    assert_non_null(strstr(r.acted, "pose refused: jump"));
    assert_true(r.is_agreed);
}

/* Commas outside quotes. */
static int32_t count_commas(const char *line)
{
    int32_t count = 0;
    bool is_quoted = false;
    for (const char *at = line; *at != '\0' && *at != '\n'; ++at) {
        is_quoted = is_quoted != (*at == '"');
        count += *at == ',' && !is_quoted;
    }
    return count;
}

/* The report has a row for every run, lost ones too, with every column of its head. */
TEST(every_run_has_a_row_with_every_column)
{
    ss_stress_case stress_case[] = {{0, SS_STRESS_CASE_CONTRADICTION, 1e4, 0.0, 3},
                                    {0, SS_STRESS_CASE_FLATTENED, 1e4, 0.5, 1},
                                    {0, SS_STRESS_CASE_FLATTENED, 1e4, 0.1, 1}};
    const ss_stability list = {
        .trial = stress_case, .count = 3, .folder = folder, .scratch = folder};
    char lost[] = "crashed: Killed, twice", *text[2] = {NULL, NULL};
    ss_sweep_run run[] = {{false, NULL}, {false, NULL}, {true, lost}};
    const ss_sweep_result result = {.is_complete = true, .count = 3, .lost = 1, .run = run};
    const ss_yardstick yardstick = {.cores = 1};
    softsim_error error = {.status = SOFTSIM_OK};
    for (int32_t i = 0; i < 2; ++i) {
        size_t size = 0;
        FILE *out = open_memstream(&text[i], &size);
        assert_non_null(out);
        assert_int_equal(ss_stability_run(&list, i, out, &error), SOFTSIM_OK);
        assert_int_equal(fclose(out), 0);
        run[i].text = text[i];
    }
    assert_int_equal(ss_stability_report(&list, &result, &yardstick, &error), SOFTSIM_OK);
    char line[1024];
    int32_t lines = 0, columns = 0;
    FILE *csv = fopen(in_folder("stability.csv"), "re");
    assert_non_null(csv);
    for (; fgets(line, sizeof line, csv) != NULL; ++lines) {
        columns = lines == 0 ? count_commas(line) : columns;
        assert_int_equal(count_commas(line), columns);
    }
    fclose(csv);
    assert_int_equal(lines, 4);
    assert_int_equal(columns, 27);
    free(text[0]);
    free(text[1]);
}

/* Fails when a run has left a file; the report's own are known. */
static int remove_report(void **state)
{
    static const char *const names[] = {"stability.csv",
                                        "stability.html",
                                        "stability-contradiction.gp",
                                        "stability-contradiction.svg",
                                        "stability-flattened.gp",
                                        "stability-flattened.svg"};
    return remove_only(names, sizeof names / sizeof *names);
}

int main(void)
{
    return run_all_tests(make_folder, remove_report);
}
