/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * One job of the accuracy report. Calibration is on the first level of the material: what shapes
 * the field is fitted to the field, then all forces are multiplied by one number so that the force
 * is right. Where nothing is pushed (gravity, pressure) that number is the field's amplitude: the
 * shape is fitted with the amplitude that suits it best, then the amplitude.
 *
 * The shape has one to three parameters, between bounds and known to a factor of a hundred, and a
 * value costs a simulation: NLopt's LN_NELDERMEAD (Nelder and Mead 1965) on their logarithms.
 * Rejected, measured on all bundled cases with --quick: LN_BOBYQA and LN_COBYLA, which end up to
 * 2 % lower in one case and as much higher in others; LN_SBPLX, a fifth slower and no better.
 */
#include <math.h>
#include <nlopt.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/accuracy/accuracy.h"
#include "case/norms.h"
#include "case/run.h"
#include "case/scratch.h"
#include "output.h"
#include "rt/memory.h"
#include "rt/vec.h"

static const double step_s = 1e-3;
static const double damping_share = 1.4;
static const double still_omega = 60.0; /* 1/s: of a model that has no motion of its own */
/* Runs a free parameter, and in a hurry. */
static const int32_t fit_most = 30, fit_quick = 12;
static const double fit_share = 0.04; /* of a level's time for each of them */
static const double fit_step = 1.5;   /* the search's first, in a logarithm */
static const double fit_end = 2e-4;   /* of the error: corners that differ by less are the last */
static const double poor_share = 0.5; /* of the field: that much wrong is said in words */
static const double pi = 3.14159265358979;
/* Of a swing of four periods: eight a period, and not longer than 100 s. */
enum { LEAST_SAMPLES = 32, MOST_SAMPLES = 100000 };

typedef struct work {
    const ss_accuracy_plan *plan;
    const ss_accuracy_job *job;
    const ss_case *c;
    const ss_case_mesh *mesh;
    const ss_model_class *model;
    ss_case_body body;
    ss_hints_body size;
    ss_hints_setting setting;
    double omega;
    char folder[SS_SCRATCH_PATH]; /* temporary */
    int32_t first;                /* level of the material */
    double longest_cpu_s;         /* of a run */
    bool is_calibrated;
    softsim_error *error;
    softsim_status status;
} work;

void ss_accuracy_job_id(const ss_accuracy_plan *plan, int32_t index, char out[256])
{
    const ss_accuracy_job *job = &plan->job[index];
    const ss_case *c = &plan->c[job->case_index];
    const ss_model_class *model = ss_accuracy_model_find(job->model);
    int32_t count = 0;
    const ss_case_mesh *mesh = ss_case_meshes(c, model != NULL && model->hints->on_surface, &count);
    snprintf(out, 256, "%s_%s_%s_%s", c->name,
             job->material >= 0 ? c->material[job->material] : "dynamic", job->model,
             mesh[job->mesh].name);
}

/* ---- runs ---- */

/* The scene's lines of the model; NULL with a fault when out of memory. */
static char *model_text(work *w)
{
    char *text = ss_accuracy_model_text(w->model, &w->setting, w->plan->set);
    if (text == NULL) {
        (void)ss_memory_fault(w->error);
    }
    return text;
}

/* But for the frequency. */
static ss_static_plan plan_level(const work *w, const char *text, double level)
{
    return (ss_static_plan){.c = w->c,
                            .body = &w->body,
                            .folder = w->folder,
                            .model = text,
                            .level = level,
                            .step_s = step_s,
                            .longest_cpu_s = w->longest_cpu_s};
}

static softsim_status run_level(work *w, double level, ss_static_run *out)
{
    w->omega = w->model->hints->omega != NULL ? w->model->hints->omega(&w->setting) : w->omega;
    w->setting.damping = damping_share * w->omega;
    char *text = model_text(w);
    if (text == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    ss_static_plan plan = plan_level(w, text, level);
    plan.omega = w->omega;
    const softsim_status status = ss_static_execute(&plan, out, w->error);
    free(text);
    return status;
}

/* The frequency that damping and ramp go by, where it does not follow from the parameters. */
static softsim_status find_omega(work *w)
{
    w->omega = still_omega;
    if (w->model->hints->omega != NULL) {
        return SOFTSIM_OK;
    }
    char *text = model_text(w);
    if (text == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    ss_static_plan plan = plan_level(w, text, w->c->level[w->first].value);
    plan.longest_cpu_s = 0.5 * w->plan->longest_cpu_s;
    double omega = (double)NAN;
    const softsim_status status = ss_static_measure(&plan, &omega, w->error);
    free(text);
    /* Faster than the step can follow is not waited for. */
    w->omega = isnan(omega) ? still_omega : fmin(omega, 0.5 * pi / step_s);
    return status;
}

static const double (*reference_of(const work *w, int32_t level))[3]
{
    return (const double(*)[3])w->body.reference[level];
}

/* ---- calibration ---- */

static void set_free(work *w, const double *x)
{
    for (int32_t k = 0; k < w->model->hints->free_count; ++k) {
        w->setting.free[k] = exp(x[k]);
    }
}

/* Does the model's scale move the field, and not the force? */
static bool is_amplitude_free(const work *w)
{
    return w->model->hints->has_scale && w->body.pushed_count == 0;
}

static double amplitude_of(const work *w, const ss_static_run *run)
{
    return ss_norms_amplitude(w->body.mesh->node_count, w->body.weight, (const double(*)[3])run->u,
                              reference_of(w, w->first));
}

/* The field's error on the first level with these parameters; not finite where there is none. */
static double field_error(work *w, const double *x)
{
    ss_static_run run = {.u = NULL};
    double error = (double)INFINITY;
    set_free(w, x);
    if (w->status == SOFTSIM_OK) {
        w->status = run_level(w, w->c->level[w->first].value, &run);
    }
    if (w->status == SOFTSIM_OK && run.is_good) {
        const double amplitude = is_amplitude_free(w) ? amplitude_of(w, &run) : 1.0;
        for (int32_t i = 0; i < w->body.mesh->node_count; ++i) {
            ss_scale3(run.u[i], run.u[i], amplitude);
        }
        error = ss_norms_compute(w->body.mesh->node_count, w->body.weight,
                                 (const double(*)[3])run.u, reference_of(w, w->first))
                    .field;
    }
    ss_static_run_fini(&run);
    return error;
}

/* The factor that the scale still lacks, from a run on the first level; 0: not to be had. */
static double missing_scale(work *w)
{
    const ss_case_level *level = &w->c->level[w->first];
    ss_static_run run = {.u = NULL};
    double factor = 0.0;
    w->status = run_level(w, level->value, &run);
    if (w->status == SOFTSIM_OK && run.is_good) {
        factor = is_amplitude_free(w) ? 1.0 / amplitude_of(w, &run)
                                      : level->force / ss_dot3(run.force, w->c->direction);
    }
    ss_static_run_fini(&run);
    return factor > 0.0 && isfinite(factor) ? factor : 0.0;
}

/* Forces are in proportion to the scale; fields only where they are small, hence three goes. */
static void fit_scale(work *w)
{
    const bool is_known = is_amplitude_free(w) || !isnan(w->c->level[w->first].force);
    const int32_t most = is_amplitude_free(w) ? 3 : 1;
    for (int32_t k = 0;
         k < most && w->model->hints->has_scale && is_known && w->status == SOFTSIM_OK; ++k) {
        const double factor = missing_scale(w);
        w->setting.scale *= factor > 0.0 ? factor : 1.0;
    }
}

typedef struct search {
    work *w;
    nlopt_opt nlopt;
    int32_t asked;
    bool has_value; /* one was finite */
} search;

static double search_value(unsigned n, const double *x, double *gradient, void *context)
{
    (void)gradient; /* never asked for */
    search *s = context;
    const double error = field_error(s->w, x);
    ++s->asked;
    s->has_value = s->has_value || isfinite(error);
    if (!s->has_value && s->asked > (int32_t)n) {
        nlopt_force_stop(s->nlopt); /* no corner of the first simplex has one: no way down */
    }
    return isfinite(error) ? error : (double)INFINITY;
}

static softsim_status fit_shape(work *w)
{
    const int32_t count = w->model->hints->free_count;
    double low[SS_HINTS_MAX_FREE], high[SS_HINTS_MAX_FREE], start[SS_HINTS_MAX_FREE];
    double x[SS_HINTS_MAX_FREE], error = (double)INFINITY;
    search s = {.w = w, .nlopt = nlopt_create(NLOPT_LN_NELDERMEAD, (unsigned)count)};
    if (s.nlopt == NULL) {
        return ss_memory_fault(w->error);
    }
    for (int32_t k = 0; k < count; ++k) {
        low[k] = log(w->model->hints->free[k].low);
        high[k] = log(w->model->hints->free[k].high);
        x[k] = start[k] = log(w->model->hints->free[k].start);
    }
    nlopt_set_lower_bounds(s.nlopt, low);
    nlopt_set_upper_bounds(s.nlopt, high);
    nlopt_set_min_objective(s.nlopt, search_value, &s);
    nlopt_set_initial_step1(s.nlopt, fit_step);
    nlopt_set_ftol_rel(s.nlopt, fit_end);
    nlopt_set_maxeval(s.nlopt, count * (w->plan->is_quick ? fit_quick : fit_most));
    nlopt_optimize(s.nlopt, x, &error);
    nlopt_destroy(s.nlopt);
    w->is_calibrated = s.has_value;
    set_free(w, s.has_value ? x : start);
    return w->status;
}

static softsim_status calibrate(work *w)
{
    w->longest_cpu_s = fit_share * w->plan->longest_cpu_s;
    if (w->model->hints->free_count > 0) {
        w->status = fit_shape(w);
    }
    fit_scale(w);
    w->longest_cpu_s = w->plan->longest_cpu_s;
    return w->status;
}

/* ---- files of a job ---- */

static softsim_status write_field(const work *w, int32_t index, int32_t level,
                                  const ss_static_run *run)
{
    char id[256], path[SS_ACCURACY_PATH + 300];
    ss_output output;
    ss_accuracy_job_id(w->plan, index, id);
    snprintf(path, sizeof path, "%s/fields/%s.csv", w->plan->folder, id);
    const softsim_status status = ss_output_open(&output, path, w->error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("node,x,y,z,ux,uy,uz,rx,ry,rz\n", output.file);
    for (int32_t i = 0; i < w->body.mesh->node_count; ++i) {
        const double *x = w->body.mesh->position[i], *u = run->u[i];
        const double *r = w->body.reference[level][i];
        fprintf(output.file, "%d,%.9g,%.9g,%.9g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g\n", w->body.number[i],
                x[0], x[1], x[2], u[0], u[1], u[2], r[0], r[1], r[2]);
    }
    return ss_output_commit(&output, w->error);
}

static softsim_status write_snippet(const work *w, int32_t index)
{
    char id[256], path[SS_ACCURACY_PATH + 300];
    ss_output output;
    ss_accuracy_job_id(w->plan, index, id);
    snprintf(path, sizeof path, "%s/scenes/%s.yaml", w->plan->folder, id);
    softsim_status status = ss_output_open(&output, path, w->error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    char *text = ss_accuracy_model_text(w->model, &w->setting, w->plan->set);
    const char *file = w->model->hints->on_surface ? w->mesh->surface : w->mesh->volume;
    fprintf(output.file, "# %s, %s%s%s\nobject: {mesh: %s, units: m}\nmodel:\n%s", w->c->name,
            w->c->material[w->job->material], w->is_calibrated ? ", calibrated on " : "",
            w->is_calibrated ? w->c->level[w->first].tag : "", file, text != NULL ? text : "");
    free(text);
    return ss_output_commit(&output, w->error);
}

static void start_row(const work *w, int32_t level, ss_accuracy_row *row)
{
    *row = (ss_accuracy_row){.nodes = w->body.mesh != NULL ? w->body.mesh->node_count : 0,
                             .error_l2 = (double)NAN,
                             .error_max = (double)NAN,
                             .error_force = (double)NAN,
                             .p50_us = (double)NAN,
                             .p99_us = (double)NAN,
                             .dt_s = (double)NAN,
                             .realtime = (double)NAN,
                             .to_1pct_ms = (double)NAN,
                             .value = w->c->level[level].value,
                             .force = (double)NAN};
    row->elements = w->body.mesh != NULL ? ss_mesh_element_count(w->body.mesh) : 0;
    snprintf(row->case_name, sizeof row->case_name, "%s", w->c->name);
    snprintf(row->material, sizeof row->material, "%s", w->c->material[w->job->material]);
    snprintf(row->model, sizeof row->model, "%s", w->job->model);
    snprintf(row->mesh, sizeof row->mesh, "%s", w->mesh->name);
    snprintf(row->level, sizeof row->level, "%s", w->c->level[level].tag);
    snprintf(row->calibrated, sizeof row->calibrated, "%s", w->is_calibrated ? "yes" : "no");
}

static void add_note(char *text, size_t size, const char *format, const char *a, const char *b)
{
    const size_t used = strlen(text);
    snprintf(text + used, size - used, format, a, b);
}

static void fill_row(const work *w, int32_t level, const ss_static_run *run, ss_accuracy_row *row)
{
    const ss_case_level *at = &w->c->level[level];
    const char *used = w->setting.material;
    start_row(w, level, row);
    snprintf(row->verdict, sizeof row->verdict, "%s", run->verdict);
    if (!run->is_refused) {
        row->p50_us = run->p50_us;
        row->p99_us = run->p99_us;
        row->dt_s = run->dt_s;
        row->realtime = run->dt_s / (1e-6 * run->p50_us);
    }
    if (!run->is_good) {
        return;
    }
    const ss_norms norms = ss_norms_compute(w->body.mesh->node_count, w->body.weight,
                                            (const double(*)[3])run->u, reference_of(w, level));
    row->error_l2 = norms.field;
    row->error_max = norms.peak;
    row->to_1pct_ms = run->to_1pct_ms;
    if (w->body.pushed_count > 0 && w->model->hints->has_force) {
        row->force = ss_dot3(run->force, w->c->direction);
        row->error_force = ss_norms_force(run->force, w->c->direction, at->force);
    } else if (w->body.pushed_count > 0) {
        add_note(row->verdict, sizeof row->verdict, "; the model has no force of its own%s%s", "",
                 "");
    }
    if (norms.field > poor_share) {
        char size[32];
        snprintf(size, sizeof size, "%.3g",
                 ss_norms_amplitude(w->body.mesh->node_count, w->body.weight,
                                    reference_of(w, level), (const double(*)[3])run->u));
        add_note(
            row->verdict, sizeof row->verdict,
            "; poor field: half of it or more is wrong, its size is %s times the reference's%s",
            size, "");
    }
    if (w->model->hints->note != NULL) {
        add_note(row->verdict, sizeof row->verdict, "; %s%s", w->model->hints->note, "");
    }
    if (used != NULL && strncmp(used, row->material, strlen(row->material)) != 0 &&
        !(strcmp(used, "neo-hookean") == 0 && strcmp(row->material, "nh") == 0)) {
        add_note(row->verdict, sizeof row->verdict, "; %s in place of %s", used, row->material);
    }
}

/* Is this level run? The first and the last of the material always. */
static bool is_wanted(const work *w, int32_t level)
{
    const bool is_last =
        level + 1 == w->c->level_count || w->c->level[level + 1].material != w->job->material;
    return w->c->level[level].material == w->job->material &&
           (!w->plan->is_quick || level == w->first || is_last);
}

static softsim_status run_levels(work *w, int32_t index, FILE *out)
{
    softsim_status status = SOFTSIM_OK;
    for (int32_t k = 0; k < w->c->level_count && status == SOFTSIM_OK; ++k) {
        if (!is_wanted(w, k)) {
            continue;
        }
        ss_static_run run = {.u = NULL};
        ss_accuracy_row row;
        status = run_level(w, w->c->level[k].value, &run);
        if (status == SOFTSIM_OK) {
            fill_row(w, k, &run, &row);
            ss_accuracy_line(out, &row, true);
        }
        if (status == SOFTSIM_OK && run.is_good) {
            status = write_field(w, index, k, &run);
        }
        ss_static_run_fini(&run);
    }
    return status == SOFTSIM_OK ? write_snippet(w, index) : status;
}

/* ---- the job ---- */

static void begin(work *w, const ss_accuracy_plan *plan, int32_t index, softsim_error *error)
{
    const ss_accuracy_job *job = &plan->job[index];
    int32_t count = 0;
    *w = (work){.plan = plan,
                .job = job,
                .c = &plan->c[job->case_index],
                .longest_cpu_s = plan->longest_cpu_s,
                .error = error};
    w->model = ss_accuracy_model_find(job->model);
    w->mesh =
        &ss_case_meshes(w->c, w->model != NULL && w->model->hints->on_surface, &count)[job->mesh];
    while (job->material >= 0 && w->first < w->c->level_count &&
           w->c->level[w->first].material != job->material) {
        ++w->first;
    }
    w->setting = (ss_hints_setting){.body = &w->size, .scale = 1.0};
    if (w->model != NULL) {
        w->setting.material = ss_accuracy_model_material(
            w->model, job->material >= 0 ? w->c->material[job->material] : "stvk");
        for (int32_t k = 0; k < w->model->hints->free_count; ++k) {
            w->setting.free[k] = w->model->hints->free[k].start;
        }
    }
}

void ss_accuracy_scratch_name(int64_t owner, char out[SS_ACCURACY_SCRATCH])
{
    snprintf(out, SS_ACCURACY_SCRATCH, "softsim-accuracy-%d", (int)owner);
}

static softsim_status prepare(work *w, int32_t material)
{
    softsim_status status =
        ss_case_load_body(w->c, w->mesh, material, w->model->hints->on_surface, &w->body, w->error);
    if (status == SOFTSIM_OK) {
        w->size = ss_accuracy_body_of(w->c, w->body.mesh);
        char name[SS_ACCURACY_SCRATCH];
        ss_accuracy_scratch_name(getppid(), name);
        status = ss_scratch_make(name, w->folder, w->error);
    }
    return status == SOFTSIM_OK ? ss_static_prepare(&w->body, w->folder, w->error) : status;
}

softsim_status ss_accuracy_run_job(const void *plan, int32_t index, FILE *out, softsim_error *error)
{
    work w;
    begin(&w, plan, index, error);
    if (w.model == NULL) {
        ss_accuracy_lose_job(plan, index, "refused: this report does not know its parameters", out);
        return SOFTSIM_OK;
    }
    softsim_status status = prepare(&w, w.job->material);
    if (status == SOFTSIM_OK) {
        status = find_omega(&w);
    }
    if (status == SOFTSIM_OK && !ss_accuracy_model_is_physical(w.model)) {
        status = calibrate(&w);
    }
    if (status == SOFTSIM_OK) {
        status = run_levels(&w, index, out);
    }
    ss_scratch_remove(w.folder);
    ss_case_body_fini(&w.body);
    return status;
}

void ss_accuracy_lose_job(const ss_accuracy_plan *plan, int32_t index, const char *reason,
                          FILE *out)
{
    work w;
    begin(&w, plan, index, NULL);
    for (int32_t k = 0; k < w.c->level_count; ++k) {
        ss_accuracy_row row;
        if (is_wanted(&w, k)) {
            start_row(&w, k, &row);
            snprintf(row.verdict, sizeof row.verdict, "%.*s", (int)strcspn(reason, "\n"), reason);
            ss_accuracy_line(out, &row, true);
        }
    }
}

/* ---- dynamics ---- */

/* The node nearest the probe. */
static int32_t probe_node(const work *w)
{
    int32_t best = 0;
    double least = (double)INFINITY;
    for (int32_t i = 0; i < w->body.mesh->node_count; ++i) {
        double d[3];
        ss_sub3(d, w->body.mesh->position[i], w->c->probe);
        if (ss_dot3(d, d) < least) {
            least = ss_dot3(d, d);
            best = i;
        }
    }
    return best;
}

/* Residual of the best a + b cos(w t) + c sin(w t) through `count` values at step_s, 2 step_s, ...:
 * normal equations, solved by elimination. */
static double wave_residual(const double *y, int32_t count, double omega)
{
    double m[3][4] = {{0}}, square = 0.0;
    for (int32_t i = 0; i < count; ++i) {
        const double t = step_s * (i + 1);
        const double base[3] = {1.0, cos(omega * t), sin(omega * t)};
        for (int r = 0; r < 3; ++r) {
            for (int k = 0; k < 3; ++k) {
                m[r][k] += base[r] * base[k];
            }
            m[r][3] += base[r] * y[i];
        }
        square += y[i] * y[i];
    }
    const double right[3] = {m[0][3], m[1][3], m[2][3]};
    for (int p = 0; p < 3; ++p) {
        for (int r = 0; r < 3; ++r) {
            const double f = r != p ? m[r][p] / m[p][p] : 0.0;
            for (int k = p; k < 4 && r != p; ++k) {
                m[r][k] -= f * m[p][k];
            }
        }
    }
    for (int p = 0; p < 3; ++p) {
        square -= right[p] * m[p][3] / m[p][p];
    }
    return square;
}

/* Hz; the frequency of the wave that leaves the least of y, of a fifth to five times the expected
 * one; NaN: of none of these. */
static double find_frequency(const double *y, int32_t count, double expected_hz)
{
    const double first = 0.2 * expected_hz, stride = 0.015 * expected_hz;
    const double last = fmin(5.0 * expected_hz, 0.4 / step_s);
    double best = (double)NAN, least = (double)INFINITY;
    for (double hz = first; hz <= last; hz += stride) {
        const double left = wave_residual(y, count, 2.0 * pi * hz);
        if (left < least) {
            least = left;
            best = hz;
        }
    }
    if (!(best > first && best + stride <= last)) {
        return (double)NAN;
    }
    for (double width = 2.0 * stride; width > 1e-6 * expected_hz; width /= 20.0) {
        const double middle = best;
        for (int k = -40; k <= 40; ++k) {
            const double hz = middle + width * k / 40.0;
            const double left = wave_residual(y, count, 2.0 * pi * hz);
            if (left < least) {
                least = left;
                best = hz;
            }
        }
    }
    return best;
}

typedef struct swing {
    double f1_error, minimum_error, rms;
    char verdict[320], notes[480]; /* the program's worst, and what each step came to */
} swing;

__attribute__((format(printf, 2, 3))) static void add_swing_note(swing *s, const char *format, ...)
{
    const size_t used = strlen(s->notes);
    va_list list;
    va_start(list, format);
    vsnprintf(s->notes + used, sizeof s->notes - used, format, list);
    va_end(list);
}

/* How bad a verdict is; refused is worse than any. */
static int severity(const char *verdict)
{
    const char *name = "refused";
    int k = SOFTSIM_VERDICT_FAULT + 1;
    while (k > 0 && strncmp(verdict, name, strlen(name)) != 0) {
        name = softsim_verdict_name((softsim_verdict)--k);
    }
    return k;
}

/* SOFTSIM_ERROR_UNSUPPORTED: there is no motion to judge; the verdict says why. */
static softsim_status swing_run(work *w, const double gravity[3], int32_t count, double (*u)[3],
                                swing *out)
{
    char verdict[320] = "";
    int32_t done = 0;
    char *text = model_text(w);
    if (text == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    const ss_static_plan plan = {
        .c = w->c, .body = &w->body, .folder = w->folder, .model = text, .step_s = step_s};
    const softsim_status status =
        ss_static_swing(&plan, gravity, probe_node(w), count, u, &done, verdict, w->error);
    free(text);
    if (out->verdict[0] == '\0' || severity(verdict) > severity(out->verdict)) {
        snprintf(out->verdict, sizeof out->verdict, "%s", verdict);
    }
    return status == SOFTSIM_OK && (done < count || severity(verdict) >= SOFTSIM_VERDICT_FAULT)
               ? SOFTSIM_ERROR_UNSUPPORTED
               : status;
}

/* Largest way along `direction`, by the parabola through the largest sample and its neighbours. */
static double largest_way(const double (*u)[3], int32_t count, const double direction[3])
{
    int32_t at = 0;
    for (int32_t i = 1; i < count; ++i) {
        at = ss_dot3(u[i], direction) > ss_dot3(u[at], direction) ? i : at;
    }
    const double y1 = ss_dot3(u[at], direction);
    if (at == 0 || at == count - 1) {
        return y1;
    }
    const double y0 = ss_dot3(u[at - 1], direction), y2 = ss_dot3(u[at + 1], direction);
    const double bend = y0 - 2.0 * y1 + y2;
    return bend < 0.0 ? y1 - 0.125 * (y2 - y0) * (y2 - y0) / bend : y1;
}

/* What has no value is worse than what has. */
static double worse(double a, double b)
{
    return isnan(a) || isnan(b) ? (double)NAN : fmax(a, b);
}

static void compare_step(const ss_case_step *step, int32_t count, const double (*u)[3], swing *out)
{
    double direction[3], error2 = 0.0, size2 = 0.0;
    int32_t compared = 0;
    ss_copy3(direction, step->gravity);
    ss_normalize3(direction);
    for (; compared < step->count && step->time[compared] <= step->until * (1.0 + 1e-9);
         ++compared) {
        const double place =
            step->time[compared] / step_s - 1.0; /* sample i is at (i + 1) step_s */
        const int32_t i = (int32_t)fmin(fmax(floor(place), -1.0), count - 2.0);
        double at[3] = {0.0}, d[3];
        for (int k = 0; k < 3; ++k) {
            const double before = i >= 0 ? u[i][k] : 0.0;
            at[k] = before + (place - i) * (u[i + 1][k] - before);
        }
        ss_sub3(d, at, step->u[compared]);
        error2 += ss_dot3(d, d);
        size2 += ss_dot3(step->u[compared], step->u[compared]);
    }
    const double expected = largest_way((const double(*)[3])step->u, compared, direction);
    const double way = largest_way(u, count, direction);
    const double minimum = fabs(way - expected) / fabs(expected), rms = sqrt(error2 / size2);
    add_swing_note(out, "; at %.3g m/s^2: first minimum %.3g, rms %.3g", ss_norm3(step->gravity),
                   minimum, rms);
    out->minimum_error = worse(out->minimum_error, minimum);
    out->rms = worse(out->rms, rms);
}

/* Small vibrations: a tenth of the first step, four periods. */
static softsim_status find_first(work *w, swing *out)
{
    double gravity[3];
    const double hz = w->c->first_frequency, samples = 4.0 / (hz * step_s);
    if (!(samples >= LEAST_SAMPLES && samples <= MOST_SAMPLES)) {
        add_swing_note(out, "; a first frequency of %.3g Hz is not shown by steps of 1 ms", hz);
        return SOFTSIM_OK;
    }
    const int32_t count = (int32_t)samples;
    double(*u)[3] = calloc((size_t)count, sizeof *u);
    double *y = calloc((size_t)count, sizeof *y);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    ss_scale3(gravity, w->c->step[0].gravity, 0.1);
    if (u == NULL || y == NULL) {
        status = ss_memory_fault(w->error);
    } else {
        status = swing_run(w, gravity, count, u, out);
    }
    if (status == SOFTSIM_OK) {
        for (int32_t i = 0; i < count; ++i) {
            y[i] = ss_dot3(u[i], gravity);
        }
        out->f1_error = fabs(find_frequency(y, count, hz) - hz) / hz;
        if (isnan(out->f1_error)) {
            add_swing_note(out, "; its first frequency is nowhere near %.3g Hz", hz);
        }
    }
    free(u);
    free(y);
    return status;
}

static softsim_status run_steps(work *w, swing *out)
{
    softsim_status status = SOFTSIM_OK;
    if (w->c->step_count > 0 && !isnan(w->c->first_frequency)) {
        status = find_first(w, out);
    }
    if (w->c->step_count > 0 && status == SOFTSIM_OK) {
        out->minimum_error = out->rms = 0.0;
    }
    for (int32_t k = 0; k < w->c->step_count && status == SOFTSIM_OK; ++k) {
        const ss_case_step *step = &w->c->step[k];
        const int32_t count = (int32_t)ceil(step->until / step_s) + 1;
        double(*u)[3] = calloc((size_t)count, sizeof *u);
        if (u == NULL) {
            return ss_memory_fault(w->error);
        }
        status = swing_run(w, step->gravity, count, u, out);
        if (status == SOFTSIM_OK) {
            compare_step(step, count, (const double(*)[3])u, out);
        }
        free(u);
    }
    if (status == SOFTSIM_ERROR_UNSUPPORTED) {
        out->minimum_error = out->rms = (double)NAN; /* the worst of all steps is not known */
        return SOFTSIM_OK;
    }
    return status;
}

softsim_status ss_accuracy_run_dynamic(const void *plan, int32_t index, FILE *out,
                                       softsim_error *error)
{
    work w;
    swing s = {.f1_error = (double)NAN, .minimum_error = (double)NAN, .rms = (double)NAN};
    softsim_status status = SOFTSIM_OK;
    begin(&w, plan, index, error);
    if (w.model == NULL || !ss_accuracy_model_is_physical(w.model)) {
        snprintf(s.verdict, sizeof s.verdict,
                 "no density and modulus of its own: its motion in time means nothing here");
    } else {
        status = prepare(&w, -1);
        if (status == SOFTSIM_OK) {
            status = run_steps(&w, &s);
        }
        ss_scratch_remove(w.folder);
        ss_case_body_fini(&w.body);
    }
    if (status == SOFTSIM_OK) {
        fprintf(out, "%s,%s,%s", w.c->name, w.job->model, w.mesh->name);
        const double value[] = {s.f1_error, s.minimum_error, s.rms};
        for (int k = 0; k < 3; ++k) {
            ss_accuracy_put(out, value[k]);
        }
        char text[sizeof s.verdict + sizeof s.notes];
        snprintf(text, sizeof text, "%s%s", s.verdict, s.notes);
        fputc(',', out);
        ss_csv_text(out, text);
        fputc('\n', out);
    }
    return status;
}
