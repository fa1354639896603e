/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-fit: a scene and measured curves to the scene with the parameters that repeat them.
 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "fit.h"
#include "output.h"
#include "process.h"
#include "rt/args.h"
#include "rt/files.h"
#include "rt/program.h"
#include "rt/progress.h"
#include "world/world.h"

enum {
    FARTHEST_M = 1000, /* places beyond are a unit error, as in pose paths */
    TOLD_SIZE = 8192,  /* bytes: what was found, at the head of the new scene */
    ROW_SIZE = 64      /* of --fitted, at most */
};

static const char about[] =
    "Finds the parameters of a scene's model that repeat measured curves.\n\n"
    "A curve is a CSV with the columns depth_m,force_n (force while pressing) or time_s,force_n\n"
    "(force while holding; time 0 is the end of the press, of --hold-depth-m). The press: the\n"
    "free surface node nearest to --at, which is a place on the surface to within a mean edge\n"
    "(default: a central node, far from what is fixed), is pressed\n"
    "along its inward normal at constant speed, in --press-s, to the curve's last depth; by the\n"
    "scene's tool of the lowest probe, its +z into the tissue, depth 0 at the first touch; "
    "without\n"
    "a tool by a patch, all free surface nodes within two mean edges, moved as one. Depth is the\n"
    "tool's travel, force the tissue's along the normal. Several curves are fitted together.\n\n"
    "With --case the model is brought to rest on the reference case's own body at every load "
    "level\n"
    "instead, and its field and its force are fitted to the reference's, each level counting the "
    "same.\n"
    "What was found is told on stderr and in the head of the new scene.";

typedef struct fit_options {
    const char *scene, *out, *fitted, *folder, *material, *mesh;
    ss_arg_list curve, at, parameter, set;
    double press_s, hold_depth_m;
    int64_t max_evaluations;
} fit_options;

enum { OUTPUT_COUNT = 2 };

static void list_outputs(const fit_options *o, ss_named_file out[OUTPUT_COUNT])
{
    out[0] = (ss_named_file){"--out", o->out};
    out[1] = (ss_named_file){"--fitted", o->fitted};
}

/* No output may be what is read. */
static void check_outputs(const fit_options *o, softsim_error *error)
{
    ss_named_file out[OUTPUT_COUNT], in[SS_ARG_LIST_MAX + 1] = {{"the scene", o->scene}};
    list_outputs(o, out);
    for (int32_t c = 0; c < o->curve.count; ++c) {
        in[c + 1] = (ss_named_file){"a --curve", o->curve.value[c]};
    }
    (void)ss_files_check(in, o->curve.count + 1, out, OUTPUT_COUNT, error);
}

static ss_args_result parse(int argc, char **argv, fit_options *out, softsim_error *error)
{
    fit_options o = {.press_s = 1.0, .max_evaluations = 300};
    const ss_arg rows[] = {
        SS_TEXT("--scene", &o.scene, "S.yaml", "the scene, with values to start from"),
        SS_LIST("--curve", &o.curve, "CSV", "a curve; may be given again"),
        SS_TEXT("--case", &o.folder, "DIR", "a reference case, instead of curves"),
        SS_TEXT("--material", &o.material, "NAME", "of the case (its first)"),
        SS_TEXT("--mesh", &o.mesh, "NAME", "of the case (its first)"),
        SS_LIST("--at", &o.at, "X,Y,Z",
                "m, world: where it is pressed; once, or once for each --curve in their order"),
        SS_LIST("--parameter", &o.parameter, "PATH",
                "model.NAME, or model.NAME.K.value of a region list (default: the material's)"),
        SS_LIST("--set", &o.set, "PATH=VALUE", "overrides one scene value, in the new scene too"),
        {"--press-s", SS_ARG_NUMBER, &o.press_s, 1e-3, 1e4, "S",
         "how long a press, or the loading of a case, takes (1)"},
        {"--hold-depth-m", SS_ARG_NUMBER, &o.hold_depth_m, 1e-9, 1e3, "M",
         "how deep is held, for curves over time"},
        {"--max-evaluations", SS_ARG_INTEGER, &o.max_evaluations, 10, 1e6, "N",
         "of all curves, at most (300)"},
        SS_TEXT("--out", &o.out, "S2.yaml", "the new scene"),
        SS_TEXT("--fitted", &o.fitted, "CSV",
                "the curves beside the model's: curve,at,force_n,fitted_n"),
    };
    const ss_args_result result = SS_ARGS_OPTIONS(
        argc, argv,
        "--scene S.yaml (--curve CSV... | --case DIR) [--parameter PATH]... --out S2.yaml", about,
        rows, error);
    *out = o;
    if (result != SS_ARGS_RUN) {
        return result;
    }
    const char *missing = !o.scene                          ? "--scene S.yaml"
                          : !o.out                          ? "--out S2.yaml"
                          : o.curve.count == 0 && !o.folder ? "--curve CSV or --case DIR"
                                                            : NULL;
    if (missing) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s is missing", missing);
    } else if (o.folder && (o.curve.count > 0 || o.at.count > 0 || o.fitted)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--case says what is pressed and how: leave out --curve, --at, --fitted");
    } else if (!o.folder && (o.material || o.mesh)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--material and --mesh choose of a case: give --case DIR");
    } else if (o.curve.count > SS_FIT_MAX_CURVES) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--curve: given more than %d times",
                          SS_FIT_MAX_CURVES);
    } else if (o.at.count > 1 && o.at.count != o.curve.count) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--at: given %d times for %d curves; give it once, or once for each",
                          o.at.count, o.curve.count);
    }
    if (error->fault_count == 0) {
        check_outputs(&o, error);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

/* "x,y,z" of --at for curve c; false without one. */
static bool read_place(const fit_options *o, int32_t c, double out[3], softsim_error *error)
{
    if (o->at.count == 0) {
        return false;
    }
    const char *text = o->at.value[o->at.count > 1 ? c : 0];
    const char *at = text;
    for (int k = 0; k < 3; ++k) {
        char *end = NULL;
        out[k] = strtod(at, &end);
        if (end == at || *end != (k < 2 ? ',' : '\0') || !isfinite(out[k])) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "--at: '%s' is not a point; give X,Y,Z in metres", text);
            return false;
        }
        if (fabs(out[k]) > FARTHEST_M) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "--at: %g m is beyond %d m; give X,Y,Z in metres", out[k],
                              FARTHEST_M);
            return false;
        }
        at = end + 1;
    }
    return true;
}

/* Nor may an output be a file that the scene names. */
static void check_scene_files(const fit_options *o, softsim_error *error)
{
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t model_count = ss_world_scene_models(models);
    ss_scene *scene = NULL;
    ss_named_file out[OUTPUT_COUNT];
    list_outputs(o, out);
    if (ss_scene_load(o->scene, o->set.value, o->set.count, models, model_count, NULL, &scene,
                      error) == SOFTSIM_OK) {
        (void)ss_scene_check_outputs(scene, out, OUTPUT_COUNT, error);
    }
    ss_scene_destroy(&scene);
}

static void choose_parameters(const fit_options *o, bool has_time, ss_fit *fit,
                              softsim_error *error)
{
    fit->parameter_count = ss_fit_choose(o->scene, o->set.value, o->set.count, o->parameter.value,
                                         o->parameter.count, has_time, fit->parameter, error);
    if (fit->parameter_count > 0) {
        check_scene_files(o, error);
    }
}

/* Parameters and the case. */
static softsim_status plan_case(const fit_options *o, ss_fit *fit, ss_fit_levels *levels,
                                softsim_error *error)
{
    fit->levels = levels;
    choose_parameters(o, false, fit, error);
    for (int32_t i = 0; i < fit->parameter_count; ++i) {
        if (strchr(fit->parameter[i].path + strlen("model."), '.')) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "%s: the scene's regions are not the case's; give one value with "
                              "--set",
                              fit->parameter[i].path);
        }
    }
    if (error->fault_count > 0) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    const softsim_status status =
        ss_fit_levels_open(o->folder, o->material, o->mesh, &fit->scene, o->press_s, levels, error);
    ss_named_file out[OUTPUT_COUNT];
    list_outputs(o, out);
    return status != SOFTSIM_OK || ss_case_check_outputs(&levels->c, out, OUTPUT_COUNT, error)
               ? status
               : SOFTSIM_ERROR_ARGUMENT;
}

/* Curves, parameters, presses. */
static softsim_status plan(const fit_options *o, ss_fit *fit, ss_fit_levels *levels,
                           softsim_error *error)
{
    bool has_time = false;
    fit->scene = (ss_press_scene){.path = o->scene, .set = o->set.value, .set_count = o->set.count};
    fit->max_evaluations = (int32_t)o->max_evaluations;
    if (o->folder) {
        return plan_case(o, fit, levels, error);
    }
    for (int32_t c = 0; c < o->curve.count; ++c) {
        ss_curve *curve = &fit->curve[fit->curve_count++];
        ss_curve_read(o->curve.value[c], curve, error);
        has_time |= curve->is_time;
        if (curve->is_time && !(o->hold_depth_m > 0.0)) {
            softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                              "%s: a curve over time needs the depth that was held: give "
                              "--hold-depth-m M",
                              curve->path);
        }
    }
    if (error->fault_count > 0) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    choose_parameters(o, has_time, fit, error);
    for (int32_t c = 0; fit->parameter_count > 0 && c < fit->curve_count; ++c) {
        const ss_curve *curve = &fit->curve[c];
        double at[3];
        const bool has_place = read_place(o, c, at, error);
        const double depth = curve->is_time ? o->hold_depth_m : curve->at[curve->count - 1];
        if (error->fault_count == 0) {
            ss_press_plan(&fit->scene, has_place ? at : NULL, depth, o->press_s, &fit->press[c],
                          error);
        }
    }
    return error->fault_count > 0 ? SOFTSIM_ERROR_ARGUMENT : SOFTSIM_OK;
}

/* ---- output ---- */

static void to_stderr(void *sink, const char *text)
{
    (void)sink;
    fprintf(stderr, "softsim-fit: %s\n", text);
}

static void to_comment(void *sink, const char *text)
{
    fprintf(sink, "# %s\n", text);
}

/* Before the first evaluation, which may take a while, there is no misfit yet. */
static void show_progress(int32_t evaluations, double misfit)
{
    ss_progress_stage("%d evaluations, misfit %.3g %%", evaluations, 100.0 * misfit);
}

/* The scene's text with the answer in it, and before it what was found, where that is known. */
static char *compose(const fit_options *o, const ss_fit *fit, bool is_found, softsim_error *error)
{
    char assignment[SS_FIT_MAX_PARAMETERS][SS_FIT_PATH_SIZE + 32];
    const char *set[SS_ARG_LIST_MAX + SS_FIT_MAX_PARAMETERS];
    int32_t count = 0;
    for (int32_t i = 0; i < o->set.count; ++i) {
        set[count++] = o->set.value[i];
    }
    for (int32_t i = 0; i < fit->parameter_count; ++i) {
        snprintf(assignment[i], sizeof assignment[i], "%s=%.6g", fit->parameter[i].path,
                 fit->value[i]);
        set[count++] = assignment[i];
    }
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t model_count = ss_world_scene_models(models);
    ss_scene *scene = NULL, *again = NULL;
    char folder[4096], *whole = NULL;
    size_t size = 0;
    const char *slash = strrchr(o->out, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - o->out) + 1 : 0, o->out);
    ss_scene_load(o->scene, set, count, models, model_count, NULL, &scene, error);
    char *text = scene ? ss_scene_rewrite(scene, set, count, folder, error) : NULL;
    FILE *stream = text ? open_memstream(&whole, &size) : NULL;
    if (stream) {
        fprintf(stream, "# Fitted by softsim-fit %s.\n", SOFTSIM_VERSION);
        if (is_found) {
            ss_fit_tell(fit, to_comment, stream);
        }
        fputs("# The comments below describe the scene before the fit; values marked \"was\" are "
              "new.\n",
              stream);
        fputs(text, stream);
        fclose(stream);
        /* What is written must be a scene, and the same one. */
        if (ss_scene_load_text(o->out, whole, size, NULL, 0, models, model_count, NULL, &again,
                               error) != SOFTSIM_OK) {
            free(whole);
            whole = NULL;
        }
    }
    ss_scene_destroy(&scene);
    ss_scene_destroy(&again);
    free(text);
    return whole;
}

/* Can the answer be written where it is to go? Asked with the start, before the work. */
static softsim_status check_composed(const fit_options *o, ss_fit *fit, softsim_error *error)
{
    for (int32_t i = 0; i < fit->parameter_count; ++i) {
        fit->value[i] = fit->parameter[i].start;
    }
    char *text = compose(o, fit, false, error);
    const bool is_good = text != NULL;
    free(text);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_SCENE;
}

/* Opens the results and takes room for them before the work, so that it is not for nothing. */
static softsim_status open_outputs(const fit_options *o, const ss_fit *fit, ss_output *scene,
                                   ss_output *fitted, softsim_error *error)
{
    struct stat known = {.st_size = 0};
    int64_t rows = 1;
    for (int32_t c = 0; c < fit->curve_count; ++c) {
        rows += fit->curve[c].count;
    }
    (void)stat(o->scene, &known); /* it has been read */
    softsim_status status = ss_output_open(scene, o->out, error);
    if (status == SOFTSIM_OK) {
        status = ss_output_reserve(scene, known.st_size + TOLD_SIZE, error);
    }
    if (status == SOFTSIM_OK && o->fitted) {
        status = ss_output_open(fitted, o->fitted, error);
        status = status == SOFTSIM_OK ? ss_output_reserve(fitted, rows * ROW_SIZE, error) : status;
    }
    return status;
}

static softsim_status write_scene(const fit_options *o, const ss_fit *fit, ss_output *output,
                                  softsim_error *error)
{
    char *text = compose(o, fit, true, error);
    if (!text) {
        return SOFTSIM_ERROR_SCENE;
    }
    fputs(text, output->file);
    free(text);
    return ss_output_commit(output, error);
}

static softsim_status write_fitted(const ss_fit *fit, ss_output *output, softsim_error *error)
{
    fprintf(output->file, "curve,at,force_n,fitted_n\n");
    for (int32_t c = 0; c < fit->curve_count; ++c) {
        for (int32_t k = 0; k < fit->curve[c].count; ++k) {
            fprintf(output->file, "%d,%.9g,%.9g,%.9g\n", c, fit->curve[c].at[k],
                    fit->curve[c].force[k], fit->force[c][k]);
        }
    }
    return ss_output_commit(output, error);
}

int main(int argc, char **argv)
{
    static softsim_error error;
    static ss_fit fit;
    static ss_fit_levels levels;
    fit_options options;
    ss_output out = {0}, fitted = {0};
    ss_program_begin();
    int exit_code = 0;
    if (!ss_args_may_run(argv[0], parse(argc, argv, &options, &error), &error, &exit_code)) {
        return ss_program_finish(argv[0], exit_code);
    }
    ss_process_catch_stop(); /* what it writes beside its results goes with it */
    fit.progress = show_progress;
    ss_progress_begin("softsim-fit", "0 evaluations");
    ss_progress_stage("0 evaluations");
    softsim_status status = plan(&options, &fit, &levels, &error);
    if (status == SOFTSIM_OK) {
        status = open_outputs(&options, &fit, &out, &fitted, &error);
    }
    if (status == SOFTSIM_OK) {
        status = check_composed(&options, &fit, &error);
    }
    exit_code = status == SOFTSIM_OK ? 0 : 2;
    if (status == SOFTSIM_OK) {
        status = ss_fit_run(&fit, &error);
        exit_code = fit.solve.evaluations <= 1 && !ss_process_is_stopped() ? 2 : 1;
    }
    ss_progress_end();
    if (status == SOFTSIM_OK) {
        ss_fit_tell(&fit, to_stderr, NULL);
        const bool is_written =
            write_scene(&options, &fit, &out, &error) == SOFTSIM_OK &&
            (!options.fitted || write_fitted(&fit, &fitted, &error) == SOFTSIM_OK);
        exit_code = is_written && fit.solve.has_settled ? 0 : 1;
    }
    ss_output_abandon(&out);
    ss_output_abandon(&fitted);
    if (error.fault_count > 0) {
        ss_args_print_error(argv[0], &error);
    }
    ss_fit_fini(&fit);
    ss_fit_levels_close(&levels);
    return exit_code;
}
