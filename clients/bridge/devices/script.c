/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A pose path file as a device: it moves along the path of its lowest probe number, one period at
 * a time, whatever force it is told to exert, and ends with the path.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "devices/script.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/vec.h"
#include "softsim/log.h"

typedef struct script {
    softsim_path *path;
    int32_t probe;
    double begin_s, end_s, period_s;
    int64_t tick;
} script;

static bool script_read(void *state, ss_device_sample *out_sample)
{
    const script *s = state;
    softsim_pose pose;
    /* The last tick may miss the end by rounding. */
    double time_s = s->begin_s + (double)s->tick * s->period_s;
    if (time_s > s->end_s && time_s < s->end_s + 1e-3 * s->period_s) {
        time_s = s->end_s;
    }
    if (!softsim_path_sample(s->path, s->probe, time_s, &pose)) {
        return false;
    }
    ss_copy3(out_sample->position, pose.position);
    ss_copy3(out_sample->true_position, pose.position);
    ss_set3(out_sample->true_velocity, NAN, NAN, NAN);
    memcpy(out_sample->orientation, pose.orientation, sizeof pose.orientation);
    out_sample->buttons = pose.buttons;
    return true;
}

static void script_exert(void *state, const double force_n[3])
{
    (void)force_n;
    ++((script *)state)->tick;
}

static void script_destroy(void *state)
{
    softsim_path_free(&((script *)state)->path);
    free(state);
}

softsim_status ss_script_create(const char *csv_path, double period_s, ss_device *out_device,
                                softsim_error *error)
{
    script *s = calloc(1, sizeof *s);
    if (s == NULL) {
        return ss_memory_fault(error);
    }
    const softsim_status status = softsim_path_load(csv_path, &s->path, error);
    if (status != SOFTSIM_OK) {
        free(s);
        return status;
    }
    char note[80];
    if (softsim_path_note(s->path, note, sizeof note)) {
        ss_plain_print(stderr, "softsim-bridge: %s: %s\n", csv_path, note);
    }
    s->period_s = period_s;
    s->probe = __builtin_ctz(softsim_path_probes(s->path));
    softsim_path_range(s->path, s->probe, &s->begin_s, &s->end_s);
    *out_device = (ss_device){.state = s,
                              .period_s = period_s,
                              .max_exerted_n = HUGE_VAL, /* it feels nothing */
                              .read = script_read,
                              .exert = script_exert,
                              .destroy = script_destroy};
    return SOFTSIM_OK;
}

/* ---- on the command line ---- */

static const char *chosen_path;
static const ss_arg options[] = {
    SS_TEXT("--path", &chosen_path, "POSES.csv", "script: time_s,probe,x,y,z,qw,qx,qy,qz,buttons"),
};

static void check(bool is_chosen, softsim_error *error)
{
    if (is_chosen != (chosen_path != NULL)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          is_chosen ? "--device script needs --path POSES.csv"
                                    : "--path: only --device script follows a path");
    }
}

static softsim_status create(const ss_device_setup *setup, ss_device *out_device,
                             softsim_error *error)
{
    return ss_script_create(chosen_path, setup->period_s, out_device, error);
}

extern const ss_device_class ss_device_script;
const ss_device_class ss_device_script = {.name = "script",
                                          .help = "a pose path",
                                          .option = options,
                                          .option_count = sizeof options / sizeof *options,
                                          .input = &chosen_path,
                                          .ends = true,
                                          .check = check,
                                          .create = create};
