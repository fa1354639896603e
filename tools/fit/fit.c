/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "fit.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "process.h"
#include "rt/memory.h"
#include "rt/printer.h"

enum { MAX_SETS = 128 };
static const double FLOOR = 0.005;      /* of the rms force: no curve is known better */
static const double ROUGH_SHARE = 0.01; /* of the largest force: below it forces count as equal */
/* Of the contact's radius a, at the deepest: longer edges of linear tetrahedra are told. The
 * modulus that fem-quadratic finds over fem's, from one curve on blocks of 3025 tetrahedra at a
 * Poisson's ratio of 0.45, by edge / a: 1.13 at 0.42, 1.26 at 0.65, 1.42 at 0.80, 1.48 at 1.09,
 * 1.69 at 1.31, 2.19 at 1.60; 1.33 for a patch. At 0.42 the fit's scatter was below 0.01. */
static const double LINEAR_EDGE = 0.4;
/* Of the depth: a tool that sinks deeper into the surface is told. The modulus found on
 * kidney-tissue over the one with a hard contact, by that share: 1.03 at 0.04, 1.09 at 0.08, 1.22
 * at 0.16, 1.6 at 0.32, 3.5 at 0.61. */
static const double SUNK_SHARE = 0.05;
static const double MISFIT_WARNING = 0.15; /* of the rms force: not the same curve */

/* One evaluation under way. */
typedef struct trial {
    ss_fit *fit;
    softsim_error *error; /* of the first evaluation, which must succeed; then NULL */
    double best;
} trial;

/* ---- evaluation ---- */

/* Presses every curve with the parameters at `value`. */
static softsim_status measure(ss_fit *fit, const double *value, softsim_error *error)
{
    char assignment[SS_FIT_MAX_PARAMETERS][SS_FIT_PATH_SIZE + 32];
    const char *set[MAX_SETS];
    int32_t count = 0;
    for (int32_t i = 0; i < fit->scene.set_count; ++i) {
        set[count++] = fit->scene.set[i];
    }
    for (int32_t i = 0; i < fit->parameter_count; ++i) {
        snprintf(assignment[i], sizeof assignment[i], "%s=%.17g", fit->parameter[i].path, value[i]);
        set[count++] = assignment[i];
    }
    const ss_press_scene scene = {.path = fit->scene.path, .set = set, .set_count = count};
    softsim_status status = SOFTSIM_OK;
    fit->run = (ss_press_run){.reason = ""};
    if (fit->levels) {
        return ss_fit_levels_measure(fit->levels, fit->parameter_count, fit->parameter, value,
                                     error);
    }
    for (int32_t c = 0; status == SOFTSIM_OK && c < fit->curve_count; ++c) {
        ss_press_run run;
        status =
            ss_press_measure(&fit->press[c], &scene, &fit->curve[c], fit->force[c], &run, error);
        fit->sunk[c] = run.sunk;
        fit->run = run.verdict > fit->run.verdict ? run : fit->run;
    }
    return status;
}

static double largest_force(const ss_curve *curve)
{
    double largest = 0.0;
    for (int32_t k = 0; k < curve->count; ++k) {
        largest = fmax(largest, fabs(curve->force[k]));
    }
    return largest;
}

/* The misfit of the last evaluation: root mean square over curves of their shares. */
static double fill_residual(const ss_fit *fit, bool is_rough, double *out)
{
    double sum = 0.0;
    int32_t at = 0;
    for (int32_t k = 0; fit->levels && k < fit->levels->residual_count; ++k) {
        out[k] = fit->levels->residual[k];
        sum += out[k] * out[k];
    }
    for (int32_t c = 0; c < fit->curve_count; ++c) {
        const ss_curve *curve = &fit->curve[c];
        const double weight = 1.0 / sqrt((double)fit->curve_count * curve->count);
        const double small = ROUGH_SHARE * largest_force(curve);
        for (int32_t k = 0; k < curve->count; ++k) {
            const double exact = weight * (fit->force[c][k] - curve->force[k]) / curve->rms;
            sum += exact * exact;
            out[at++] =
                is_rough
                    ? weight * (asinh(fit->force[c][k] / small) - asinh(curve->force[k] / small))
                    : exact;
        }
    }
    return sqrt(sum);
}

static bool evaluate(void *context, const double *x, bool is_rough, double *out)
{
    trial *t = context;
    ss_fit *fit = t->fit;
    double value[SS_FIT_MAX_PARAMETERS];
    if (ss_process_is_stopped()) { /* the search comes to its end without further runs */
        return false;
    }
    for (int32_t i = 0; i < fit->parameter_count; ++i) {
        value[i] = fmax(fit->parameter[i].min, fmin(fit->parameter[i].max, exp(x[i])));
    }
    softsim_error *error = t->error;
    t->error = NULL;
    if (measure(fit, value, error) != SOFTSIM_OK) {
        return false;
    }
    t->best = fmin(t->best, fill_residual(fit, is_rough, out));
    if (fit->progress) {
        fit->progress(fit->solve.evaluations, t->best);
    }
    return true;
}

/* ---- the fit ---- */

static softsim_status check_start(ss_fit *fit, softsim_error *error)
{
    int32_t points = fit->levels ? fit->levels->residual_count : 0;
    for (int32_t c = 0; c < fit->curve_count; ++c) {
        points += fit->curve[c].count;
        fit->force[c] = calloc((size_t)fit->curve[c].count, sizeof *fit->force[c]);
        if (!fit->force[c]) {
            return ss_memory_fault(error);
        }
    }
    if (points < fit->parameter_count) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "%d parameters from %d points: every answer would fit; name fewer with "
                          "--parameter",
                          fit->parameter_count, points);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    double start[SS_FIT_MAX_PARAMETERS];
    for (int32_t i = 0; i < fit->parameter_count; ++i) {
        start[i] = fit->parameter[i].start;
    }
    const softsim_status status = measure(fit, start, error);
    bool has_force = fit->levels != NULL;
    for (int32_t c = 0; status == SOFTSIM_OK && c < fit->curve_count; ++c) {
        for (int32_t k = 0; k < fit->curve[c].count; ++k) {
            has_force |= fit->force[c][k] != 0.0;
        }
    }
    if (status == SOFTSIM_OK && !has_force) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "%s: the model answers the press with no force at all, so there is "
                          "nothing to fit; press deeper, or use a model that has forces",
                          fit->scene.path);
        return SOFTSIM_ERROR_SCENE;
    }
    return status;
}

softsim_status ss_fit_run(ss_fit *fit, softsim_error *error)
{
    const softsim_status status = check_start(fit, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    trial t = {.fit = fit, .error = error, .best = INFINITY};
    ss_solve *s = &fit->solve;
    *s = (ss_solve){.n = fit->parameter_count,
                    .residual = evaluate,
                    .context = &t,
                    .floor = FLOOR,
                    .max_evaluations = fit->max_evaluations,
                    .m = fit->levels ? fit->levels->residual_count : 0};
    for (int32_t c = 0; c < fit->curve_count; ++c) {
        s->m += fit->curve[c].count;
    }
    for (int32_t i = 0; i < s->n; ++i) {
        s->start[i] = log(fit->parameter[i].start);
        s->lower[i] = log(fit->parameter[i].min);
        s->upper[i] = log(fit->parameter[i].max);
    }
    if (!ss_solve_run(s) && !ss_process_is_stopped()) {
        if (error->fault_count == 0) {
            softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "the search could not be made");
        }
        return error->status;
    }
    for (int32_t i = 0; i < s->n; ++i) { /* as they will be written */
        char text[32];
        snprintf(text, sizeof text, "%.6g", exp(s->x[i]));
        fit->value[i] =
            fmax(fit->parameter[i].min, fmin(fit->parameter[i].max, strtod(text, NULL)));
    }
    return measure(fit, fit->value, error); /* says so where it was stopped */
}

void ss_fit_fini(ss_fit *fit)
{
    for (int32_t c = 0; c < fit->curve_count; ++c) {
        ss_curve_fini(&fit->curve[c]);
        ss_press_fini(&fit->press[c]);
        free(fit->force[c]);
        fit->force[c] = NULL;
    }
}

/* ---- in words ---- */

static void tell_parameter(const ss_fit *fit, const ss_printer *t, int32_t i)
{
    const ss_solve *s = &fit->solve;
    const ss_fit_parameter *p = &fit->parameter[i];
    char known[96];
    if (s->spread[i] > log(2.0)) {
        snprintf(known, sizeof known, "not told by the data");
    } else if (s->spread[i] < 0.2) {
        snprintf(known, sizeof known, "within %.2g %% by the scatter of the fit alone",
                 100.0 * s->spread[i]);
    } else {
        snprintf(known, sizeof known, "within a factor of %.2g by the scatter of the fit alone",
                 exp(s->spread[i]));
    }
    ss_say(t, "%s = %.6g (from %.6g): %s", p->path, fit->value[i], p->start, known);
    if (s->at_bound[i] != 0) {
        const double bound = s->at_bound[i] > 0 ? p->max : p->min;
        ss_say(t,
               "%s is at its %s bound, %.6g: the curve asks for more than the model takes, or "
               "than a factor of 10,000 from the start",
               p->path, s->at_bound[i] > 0 ? "upper" : "lower", bound);
    }
}

/* What a flat direction means. */
static void tell_flat(const ss_fit *fit, const ss_printer *t, int32_t k)
{
    const ss_solve *s = &fit->solve;
    const int32_t alone = ss_solve_alone(s, k);
    if (alone >= 0) {
        const ss_fit_parameter *p = &fit->parameter[alone];
        const bool is_alpha = strstr(p->path, ".alpha") != NULL;
        ss_say(t, "the data cannot tell %s: anything from %.3g to %.3g fits as well%s", p->path,
               exp(s->low[alone]), exp(s->high[alone]),
               is_alpha ? " (a curve tells it only by its toe: a soft beginning)" : "");
        return;
    }
    char list[768] = "";
    size_t used = 0;
    for (int32_t i = 0; i < s->n && used < sizeof list; ++i) {
        const double factor = exp(log(2.0) * s->direction[k][i]);
        if (fabs(s->direction[k][i]) > 0.1) {
            const int length = snprintf(list + used, sizeof list - used, "%s%s times %.3g",
                                        used > 0 ? ", " : "", fit->parameter[i].path, factor);
            used += length > 0 ? (size_t)length : 0;
        }
    }
    ss_say(t,
           "the data cannot tell these apart: %s together fit as well; fix one with --set and "
           "leave it out of --parameter, or give a curve that tells",
           list);
}

static void tell_levels(const ss_fit_levels *levels, const ss_printer *t)
{
    char force[64] = "its forces are not known";
    if (!isnan(levels->force_misfit)) {
        snprintf(force, sizeof force, "of the force %.2g %%", 100.0 * levels->force_misfit);
    }
    ss_say(t, "%s, %s, mesh %s, %d levels: misfit of the field %.2g %%, %s", levels->c.name,
           levels->c.material[levels->material], levels->mesh, levels->level_count,
           100.0 * levels->field_misfit, force);
}

/* Is the mesh too stiff for the constant to be the tissue's? */
static void tell_mesh(const ss_curve *curve, const ss_press *press, const ss_printer *t)
{
    const bool is_tool = press->probe >= 0;
    if (press->is_stiff && press->edge > LINEAR_EDGE * press->contact) {
        ss_say(t,
               "%s: linear tetrahedra answer too stiffly, with edges of %.3g mm and a contact of "
               "%.3g mm radius: what is found makes up for that and is too soft: it fits this "
               "mesh, not the tissue; take fem-quadratic%s",
               curve->path, 1e3 * press->edge, 1e3 * press->contact,
               is_tool ? ", or a finer mesh" : "");
    } else if (is_tool && press->edge > press->tool_radius) {
        ss_say(t,
               "%s: the mesh is coarse for the tool, edges of %.3g mm and a radius of %.3g mm: "
               "it answers too stiffly, and what is found is too soft; take a finer mesh "
               "(softsim-mesh)",
               curve->path, 1e3 * press->edge, 1e3 * press->tool_radius);
    }
}

/* Is so much of the depth the contact's own give that the constant makes up for it? */
static void tell_contact(const ss_curve *curve, const ss_press *press, double sunk,
                         const ss_printer *t)
{
    if (sunk > SUNK_SHARE * press->depth) {
        ss_say(
            t,
            "%s: the contact is soft for this tissue: the tool sinks %.3g mm into it, %.0f %% of "
            "the depth; what is found makes up for that and is too stiff; raise "
            "contact.stiffness_n_per_m3 (or contact.working_force_n)",
            curve->path, 1e3 * sunk, 100.0 * sunk / press->depth);
    }
}

void ss_fit_tell(const ss_fit *fit, void (*line)(void *sink, const char *text), void *sink)
{
    const ss_printer t = {line, sink};
    const ss_solve *s = &fit->solve;
    if (fit->levels) {
        tell_levels(fit->levels, &t);
    }
    for (int32_t c = 0; c < fit->curve_count; ++c) {
        const ss_curve *curve = &fit->curve[c];
        const ss_press *press = &fit->press[c];
        double sum = 0.0;
        for (int32_t k = 0; k < curve->count; ++k) {
            const double miss = fit->force[c][k] - curve->force[k];
            sum += miss * miss;
        }
        const double rms = sqrt(sum / curve->count);
        ss_say(&t,
               "%s: %d points, misfit %.3g N rms, %.2g %% of the rms force; pressed at "
               "%.4g %.4g %.4g m by %s, %.4g m in %.4g s",
               curve->path, curve->count, rms, 100.0 * rms / curve->rms, press->point[0],
               press->point[1], press->point[2], press->probe < 0 ? "a patch" : "the tool",
               press->depth, press->press_s);
    }
    for (int32_t c = 0; c < fit->curve_count; ++c) {
        tell_mesh(&fit->curve[c], &fit->press[c], &t);
        tell_contact(&fit->curve[c], &fit->press[c], fit->sunk[c], &t);
    }
    for (int32_t i = 0; i < s->n; ++i) {
        tell_parameter(fit, &t, i);
    }
    for (int32_t k = 0; k < s->n; ++k) {
        if (s->is_flat[k]) {
            tell_flat(fit, &t, k);
        }
    }
    if (s->misfit > MISFIT_WARNING) {
        ss_say(&t, "no parameters fit the data: the model's curve has a different shape");
    }
    if (fit->run.verdict > SOFTSIM_VERDICT_GOOD) {
        ss_say(&t, "the model's own verdict in these runs: %s", fit->run.reason);
    }
    if (!s->has_settled) {
        ss_say(&t, "not settled after %d evaluations: allow more with --max-evaluations",
               s->evaluations);
    }
}
