/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/hands.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/core/report.h"
#include "bench/felt/hand.h"
#include "bench/felt/report.h"
#include "output.h"
#include "rt/args.h"
#include "world/world.h"

enum { MAX_NUMBERS = 16, BODIES = 3, GRIPS = 3, SCRIPTS = 4 };
static const char *const body_name[] = {"light", "medium", "heavy"};
static const char *const grip_name[] = {"soft", "medium", "firm"};
static const char *const script_name[] = {"press", "poke", "tap", "slide"};
static const double run_s = 2.0, good_chatter_m = 0.05e-3;
/* The defaults of a scene's haptic.coupling. */
static const double stiffness_n_per_m = 800.0, damping_n_s_per_m = 2.0;
static const char head[] =
    "tissue,rate_hz,script,body,grip,delay_ms,loss,outlier,corrected,net_energy_j,stored_j,"
    "chatter_m,steepness,stiffness_limit_n_per_m,damped_ticks,backoffs,verdict";

typedef struct hands {
    ss_arg_list scene, set;
    const char *rates, *delays, *tissues, *out;
    double loss, outlier;
    bool is_hands, is_quick;
    double rate_hz[MAX_NUMBERS], delay_ms[MAX_NUMBERS], tissue_n_per_m[MAX_NUMBERS];
    int32_t rate_count, delay_count, tissue_count;
    FILE *csv;
    int32_t rows, bad;
} hands;

static ss_args_result parse_options(int argc, char **argv, hands *h, softsim_error *error)
{
    *h = (hands){.out = "felt-report", .delays = "0,1,2,5,10"};
    const ss_arg rows[] = {
        SS_FLAG("--hands", &h->is_hands, "this report"),
        SS_LIST("--scene", &h->scene, "SCENE.yaml",
                "a scene with a tool in the chains' place; may be given again"),
        SS_LIST("--set", &h->set, "PATH=VALUE",
                "overrides one value of the scenes; may be given again"),
        SS_TEXT("--tissues", &h->tissues, "N,N",
                "stiffness of the chains, N/m (50,150,300,1000,3000; quick: 300)"),
        SS_TEXT("--rates", &h->rates, "N,N",
                "of the simulation, Hz, 10 to 1000 (60,1000; quick: 1000)"),
        SS_TEXT("--delays-ms", &h->delays, "N,N", "of the bus, one way, 0 to 20 (0,1,2,5,10)"),
        {"--loss", SS_ARG_NUMBER, &h->loss, 0, 0.9, "SHARE", "of messages on the bus (0)"},
        {"--outlier", SS_ARG_NUMBER, &h->outlier, 0, 0.9, "SHARE",
         "of messages that come 5 to 20 ms later (0)"},
        SS_FLAG("--quick", &h->is_quick, "one tissue, one rate"),
        SS_TEXT("--out", &h->out, "DIR", "for felt-hands.csv (felt-report)"),
    };
    const ss_args_result result = ss_args_parse(
        argc, argv, "--hands [options]",
        "Plays press, poke, tap and slide of three simulated devices in three grips, with and "
        "without the bridge's correction of forces, against chains of masses of known stiffness "
        "or scenes, in closed loop and without a clock.\n"
        "felt-hands.csv: net_energy_j: of the worst contact, negative: the hand was driven; "
        "stored_j: what that had taken at most; steepness: largest felt change of the force with "
        "position over 5 ms, over the stiffness limit (chains alone); damped_ticks, backoffs: "
        "what the server did against it. Good: press, poke and slide give at most 1 mJ or 5 % of "
        "stored_j, taps 3 mJ up to 5 ms and 8 mJ beyond; chatter below 0.05 mm.",
        rows, (int32_t)(sizeof rows / sizeof rows[0]), NULL, 0, 0, NULL, error);
    if (result != SS_ARGS_RUN) {
        return result;
    }
    h->tissues = h->tissues ? h->tissues : h->is_quick ? "300" : "50,150,300,1000,3000";
    h->rates = h->rates ? h->rates : h->is_quick ? "1000" : "60,1000";
    h->rate_count =
        ss_felt_numbers("--rates", false, h->rates, 10.0, 1000.0, MAX_NUMBERS, h->rate_hz, error);
    h->delay_count = ss_felt_numbers("--delays-ms", false, h->delays, 0.0, 20.0, MAX_NUMBERS,
                                     h->delay_ms, error);
    h->tissue_count = ss_felt_numbers("--tissues", false, h->tissues, 1.0, 1e5, MAX_NUMBERS,
                                      h->tissue_n_per_m, error);
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

static softsim_status play(hands *h, const ss_hand_run *run, const char *tissue,
                           softsim_error *error)
{
    ss_hand_outcome out;
    const softsim_status status = ss_hand_play(run, &out, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const bool is_still = out.felt.chatter_m.value < good_chatter_m;
    const char *verdict = !out.is_passive ? "drives the hand" : is_still ? "good" : "chatters";
    ss_csv_text(h->csv, tissue);
    fprintf(h->csv, ",%g,%s,%s,%s,%g,%g,%g,%d,%.6g,%.6g,%.6g,", run->rate_hz,
            script_name[run->script], body_name[run->body], grip_name[run->grip], run->bus.delay_ms,
            run->bus.loss, run->bus.outlier, run->is_correcting, out.net_j, out.peak_j,
            out.felt.chatter_m.value);
    if (run->scene == NULL) {
        fprintf(h->csv, "%.4g,%.4g,%lld,%lld", out.steepness, out.least_limit_n_per_m,
                (long long)out.damped_ticks, (long long)out.backoffs);
    } else {
        fputs(",,,", h->csv);
    }
    fprintf(h->csv, ",%s\n", verdict);
    ++h->rows;
    h->bad += !out.is_passive || !is_still;
    return SOFTSIM_OK;
}

/* All hands, rates and delays against one tissue. */
static softsim_status play_all(hands *h, const ss_hand_run *tissue, const char *name,
                               softsim_error *error)
{
    const int32_t buses = h->rate_count * h->delay_count;
    const int32_t count = buses * 2 * SCRIPTS * BODIES * GRIPS;
    softsim_status status = SOFTSIM_OK;
    for (int32_t n = 0; n < count && status == SOFTSIM_OK; ++n) {
        const int32_t hand = n % (BODIES * GRIPS), task = n / (BODIES * GRIPS) % SCRIPTS;
        const int32_t rest = n / (BODIES * GRIPS * SCRIPTS);
        ss_hand_run run = *tissue;
        run.body = (ss_sim_body)(hand / GRIPS);
        run.grip = (ss_sim_grip)(hand % GRIPS);
        run.script = (ss_sim_script)task;
        run.is_correcting = rest % 2 != 0;
        run.bus = (ss_bus_config){.delay_ms = h->delay_ms[rest / 2 % h->delay_count],
                                  .loss = h->loss,
                                  .outlier = h->outlier};
        run.rate_hz = h->rate_hz[rest / 2 / h->delay_count];
        status = play(h, &run, name, error);
    }
    return status;
}

static softsim_status play_scene(hands *h, const char *path, const ss_hand_run *common,
                                 softsim_error *error)
{
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t model_count = ss_world_scene_models(models);
    ss_scene *scene = NULL;
    ss_felt_place place;
    softsim_status status =
        ss_scene_load(path, h->set.value, h->set.count, models, model_count, NULL, &scene, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    const bool is_found = ss_felt_find_place(scene, &place);
    ss_scene_destroy(&scene);
    if (!is_found) {
        status = SOFTSIM_ERROR_SCENE;
        softsim_error_add(error, status, "%s: has no tool, or no surface to press", path);
        return status;
    }
    ss_hand_run run = *common;
    run.scene = path;
    run.place = &place;
    run.set = h->set.value;
    run.set_count = h->set.count;
    return play_all(h, &run, path, error);
}

static softsim_status write_report(hands *h, softsim_error *error)
{
    ss_output csv;
    softsim_status status = ss_report_csv_open(&csv, h->out, "felt-hands", head, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    h->csv = csv.file;
    ss_hand_run run = {.seed = 1,
                       .seconds = run_s,
                       .stiffness_n_per_m = stiffness_n_per_m,
                       .damping_n_s_per_m = damping_n_s_per_m};
    for (int32_t k = 0; k < h->scene.count && status == SOFTSIM_OK; ++k) {
        status = play_scene(h, h->scene.value[k], &run, error);
    }
    for (int32_t k = 0; k < h->tissue_count && h->scene.count == 0 && status == SOFTSIM_OK; ++k) {
        char name[32];
        snprintf(name, sizeof name, "%g N/m", h->tissue_n_per_m[k]);
        run.tissue_n_per_m = h->tissue_n_per_m[k];
        status = play_all(h, &run, name, error);
    }
    if (status != SOFTSIM_OK) {
        ss_output_abandon(&csv);
        return status;
    }
    status = ss_output_commit(&csv, error);
    if (status == SOFTSIM_OK) {
        printf("%d runs, %d not good: %s/felt-hands.csv\n", h->rows, h->bad, h->out);
    }
    return status;
}

int ss_felt_hands(int argc, char **argv)
{
    hands h;
    softsim_error error = {.status = SOFTSIM_OK};
    int exit_code = EXIT_FAILURE;
    const ss_args_result parsed = parse_options(argc, argv, &h, &error);
    if (ss_args_may_run(argv[0], parsed, &error, &exit_code)) {
        softsim_status status = ss_report_make_folder(h.out, &error);
        status = status == SOFTSIM_OK ? write_report(&h, &error) : status;
        exit_code = ss_args_finish(argv[0], status, &error);
    }
    return exit_code;
}
