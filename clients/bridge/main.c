/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-bridge: options, set-up and the summary. */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bridge.h"
#include "output.h"
#include "process.h"
#include "rt/args.h"
#include "rt/files.h"
#include "rt/program.h"
#include "rt/thread.h"
#include "rt/vec.h"
#include "silence.h"
#include "softsim/client.h"
#include "tissue.h"

enum { DEFAULT_TICKS = 2000, MAX_OPTIONS = 64, MAX_NAMES = 256 };
static const double HEARD_S = 2.0; /* a server that runs has said something */

typedef struct options {
    const char *lcm_url, *prefix, *csv, *axes, *offset;
    int32_t device, correct;
    const ss_device_class *kind; /* of the device */
    int64_t probe, seed, delay_ticks, ticks;
    double rate_hz, scale, force_scale, duration_s, damping;
    double delay_ms, jitter_ms, loss, outlier, linear_tissue;
} options;

static const char usage[] = "--device NAME [options]";
static const char about[] =
    "Connects a device to a softsimd: poses at 1 kHz, forces corrected to the present position.";

/* Is the tissue to be found? A simulated hand moves about the contact, wherever that is. */
static bool is_auto(const options *o)
{
    return o->offset != NULL ? strcmp(o->offset, "auto") == 0
                             : o->kind != NULL && o->kind->is_hand && isnan(o->linear_tissue);
}

/* Options that only one device or one mode knows are faults elsewhere. */
static void check_options(const options *o, const char *names, softsim_error *error)
{
    const ss_device_class *kind = o->kind;
    const ss_named_file in = {"the device's file", kind && kind->input ? *kind->input : NULL};
    const ss_named_file out = {"--csv", o->csv};
    const bool is_linear = !isnan(o->linear_tissue);
    if (!kind) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--device is missing; give %s", names);
    }
    int32_t count = 0;
    const ss_device_class *const *table = ss_device_table(&count);
    for (int32_t i = 0; i < count; ++i) {
        if (table[i]->check) {
            table[i]->check(table[i] == kind, error);
        }
    }
    if (is_linear && ((kind && !kind->is_hand) || o->scale != 1.0 || o->force_scale != 1.0 ||
                      strcmp(o->axes, "x,y,z") != 0 || o->offset != NULL ||
                      o->delay_ms + o->jitter_ms + o->loss + o->outlier > 0.0)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--linear-tissue goes with --device sim, in the contact frame, and knows "
                          "no delay but --delay-ticks");
    }
    if (!is_linear && o->delay_ticks > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--delay-ticks goes with --linear-tissue; give --delay-ms");
    }
    (void)ss_files_check(&in, 1, &out, 1, error);
}

/* Appends `text` to `list`, `before` before it. */
static void join(char list[MAX_NAMES], const char *before, const char *text)
{
    const size_t length = strlen(list);
    (void)snprintf(list + length, MAX_NAMES - length, "%s%s", before, text);
}

static ss_args_result parse_options(int argc, char **argv, options *o, softsim_error *error)
{
    int32_t kinds = 0;
    const ss_device_class *const *table = ss_device_table(&kinds);
    char names[MAX_NAMES] = "", help[MAX_NAMES] = "";
    for (int32_t i = 0; i < kinds; ++i) {
        join(names, i > 0 ? "|" : "", table[i]->name);
        join(help, i > 0 ? ", or " : "", table[i]->help);
    }
    *o = (options){.device = -1,
                   .seed = 1,
                   .rate_hz = 1000.0,
                   .scale = 1.0,
                   .force_scale = 1.0,
                   .axes = "x,y,z",
                   .linear_tissue = NAN};
    const ss_arg common[] = {
        SS_CHOICE("--device", &o->device, names, help),
        {"--probe", SS_ARG_INTEGER, &o->probe, 0, SOFTSIM_MAX_PROBES - 1, "N", "its number (0)"},
        {"--rate", SS_ARG_NUMBER, &o->rate_hz, 100, 4000, "HZ", "poses a second (1000)"},
        {"--duration", SS_ARG_NUMBER, &o->duration_s, 1e-3, 1e6, "S",
         "ends after S (without: at the path's end, or when stopped)"},
        SS_TEXT("--axes", &o->axes, "x,-z,y",
                "the device axis, with sign, of each world axis (x,y,z)"),
        {"--scale", SS_ARG_NUMBER, &o->scale, 1e-3, 1e3, "X", "world metres a device metre (1)"},
        SS_TEXT(
            "--offset-m", &o->offset, "X,Y,Z|auto",
            "world position of the device's origin (0,0,0); auto, which sim has by itself: where "
            "the tool just touches the tissue as the server publishes it, coming along the "
            "device's -z"),
        {"--force-scale", SS_ARG_NUMBER, &o->force_scale, 0, 100, "X",
         "device newtons a world newton (1)"},
        SS_CHOICE("--correct", &o->correct, "on|off",
                  "correct forces to the present position (on)"),
        {"--damping", SS_ARG_NUMBER, &o->damping, 0, 20, "N_S_PER_M",
         "the bridge's own damping in contact (0)"},
        SS_TEXT("--csv", &o->csv, "OUT.csv", ss_bridge_csv_help),
        SS_ARG_BUS(&o->lcm_url, &o->prefix),
        {"--seed", SS_ARG_INTEGER, &o->seed, 0, 9007199254740992.0, "N", "sim: tremor, bus (1)"},
        {"--delay-ms", SS_ARG_NUMBER, &o->delay_ms, 0, 200, "MS", "bus, one way (0)"},
        {"--jitter-ms", SS_ARG_NUMBER, &o->jitter_ms, 0, 50, "MS", "bus: mean further delay (0)"},
        {"--loss", SS_ARG_NUMBER, &o->loss, 0, 1, "SHARE", "bus: messages lost (0)"},
        {"--outlier", SS_ARG_NUMBER, &o->outlier, 0, 1, "SHARE",
         "bus: messages 5 to 20 ms later (0)"},
        {"--linear-tissue", SS_ARG_NUMBER, &o->linear_tissue, 0, 1e5, "N_PER_M",
         "sim: no server, a linear tissue at z = 0"},
        {"--delay-ticks", SS_ARG_INTEGER, &o->delay_ticks, 0, 1000, "N",
         "linear tissue: age of the pose answered (0)"},
        {"--ticks", SS_ARG_INTEGER, &o->ticks, 1, 1e9, "N",
         "ends after N periods (linear tissue: 2000)"},
    };
    ss_arg rows[MAX_OPTIONS];
    int32_t row_count = sizeof common / sizeof *common;
    memcpy(rows, common, sizeof common);
    for (int32_t i = 0; i < kinds; ++i) {
        if (row_count + table[i]->option_count > MAX_OPTIONS) {
            softsim_error_add(error, SOFTSIM_ERROR_UNSUPPORTED,
                              "device %s has too many options: raise MAX_OPTIONS in bridge/main.c",
                              table[i]->name);
            return SS_ARGS_BAD;
        }
        /* A device without options may have no table of them. */
        for (int32_t k = 0; k < table[i]->option_count; ++k) {
            rows[row_count++] = table[i]->option[k];
        }
    }
    const ss_args_result result =
        ss_args_parse(argc, argv, usage, about, rows, row_count, NULL, 0, 0, NULL, error);
    if (result != SS_ARGS_RUN) {
        return result;
    }
    o->kind = o->device >= 0 ? table[o->device] : NULL;
    check_options(o, names, error);
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

static int64_t tick_count(const options *o)
{
    const int64_t by_time =
        o->duration_s > 0.0 ? (int64_t)ceil(o->duration_s * o->rate_hz) : INT64_MAX;
    const int64_t by_ticks =
        o->ticks > 0 ? o->ticks
                     : (isnan(o->linear_tissue) || o->duration_s > 0.0 ? INT64_MAX : DEFAULT_TICKS);
    return by_time < by_ticks ? by_time : by_ticks;
}

/* The device's own direction towards the hand, in the world. */
static void find_towards(const ss_frame *frame, double out[3])
{
    static const double up[3] = {0.0, 0.0, 1.0};
    ss_frame_velocity(frame, up, out);
    ss_normalize3(out);
}

/* For a server to say anything before the start: not longer than the run itself is to be, but that
 * one which runs answers within 2 s. */
static double start_patience_s(const options *o)
{
    return o->duration_s > 0.0 ? fmin(fmax(o->duration_s, HEARD_S), SS_TISSUE_START_S)
                               : SS_TISSUE_START_S;
}

/* Puts the device's origin where the tool just touches. False with the reason. */
static bool place_above(const char *program, const options *o, ss_frame *frame,
                        softsim_error *error)
{
    const softsim_client_config config = {.lcm_url = o->lcm_url, .prefix = o->prefix};
    ss_tissue tissue;
    ss_touch touch;
    double towards[3];
    if (!ss_tissue_hear(&config, (int32_t)o->probe, start_patience_s(o), &tissue, error)) {
        return false;
    }
    find_towards(frame, towards);
    const bool is_found = ss_touch_find(&tissue.body, towards, &tissue.end, &touch);
    const char *tool = tissue.tool;
    ss_tissue_free(&tissue);
    if (!is_found) {
        softsim_error_add(
            error, SOFTSIM_ERROR_ARGUMENT,
            "--offset-m auto: from %.2g,%.2g,%.2g no free tissue can be pressed; come "
            "from another side, such as --axes z,x,y (from +x) or x,-y,-z (from -z), "
            "or give --offset-m X,Y,Z",
            towards[0], towards[1], towards[2]);
        return false;
    }
    ss_copy3(frame->offset_m, touch.origin);
    fprintf(stderr, "%s: --offset-m %.4f,%.4f,%.4f is where the %s just touches the tissue\n",
            program, touch.origin[0], touch.origin[1], touch.origin[2], tool);
    return true;
}

/* A run that touched nothing: how near was the tissue? */
static void tell_miss(const char *program, const softsim_client_config *config, int32_t probe,
                      const ss_bridge_summary *s)
{
    ss_tissue tissue;
    softsim_error error = {.status = SOFTSIM_OK};
    double least = INFINITY, place[3] = {0}, nearest[3], on[3] = {0};
    if (!ss_tissue_hear(config, probe, HEARD_S, &tissue, &error)) {
        fprintf(stderr, "%s: the tool has touched nothing, and how far it was cannot be told\n",
                program);
        return;
    }
    for (int32_t i = 0; i < s->way_count; ++i) {
        const double distance = ss_touch_distance(&tissue.body, s->way[i], nearest);
        if (distance < least) {
            least = distance;
            ss_copy3(place, s->way[i]);
            ss_copy3(on, nearest);
        }
    }
    fprintf(
        stderr,
        "%s: the tool has touched nothing: at its nearest, %.4f,%.4f,%.4f, its centre was %.1f "
        "mm from the tissue at %.4f,%.4f,%.4f, and the %s reaches %.1f mm; give --offset-m auto, "
        "or another --offset-m\n",
        program, place[0], place[1], place[2], 1e3 * least, on[0], on[1], on[2], tissue.tool,
        1e3 * (tissue.end.below + (tissue.end.is_round ? tissue.end.radius : 0.0)));
    ss_tissue_free(&tissue);
}

static void report(const ss_bridge_summary *s, bool is_linear)
{
    const double ticks = s->ticks > 0 ? (double)s->ticks : 1.0;
    printf("ticks       %" PRId64 ", %" PRId64 " late\n", s->ticks, s->late_ticks);
    if (!is_linear) {
        printf("forces      %" PRId64 " received, %" PRId64 " poses answered, %" PRId64
               " messages lost on the simulated bus\n",
               s->forces, s->answered, s->lost);
        if (s->others > 0) {
            printf("probe       another sender held it for %.1f s\n", s->other_s);
        }
        printf("latency_us  mean %.0f max %.0f\n",
               s->latency_sum_us / (s->answered > 0 ? (double)s->answered : 1.0),
               s->max_latency_us);
    }
    ss_halt_print(&s->halt, stdout, "halt        ");
    ss_bridge_print_peak(s, is_linear, stdout);
    printf("contact     %.1f %% of the time\n", 100.0 * (double)s->contact_ticks / ticks);
    printf("energy in   %.6g J\n", s->energy_in_j);
}

/* Were all forces those of one server's body, never away for long, and there at the end? */
static bool is_whole(const ss_bridge_summary *summary)
{
    return !summary->has_withheld && summary->changed_ns == 0 && !summary->has_gap &&
           !summary->has_stopped && !ss_halt_is_seen(&summary->halt);
}

/* What the loop could not tell: its end came first, or stderr had no room. */
static void tell_halt(const char *program, const ss_bridge *bridge)
{
    const ss_halt *halt = &bridge->summary.halt;
    if ((halt->fault_seq != 0 && !bridge->is_fault_told) ||
        (halt->pause_seq != 0 && !bridge->is_pause_told)) {
        char before[64];
        snprintf(before, sizeof before, "%.40s: ", program);
        ss_halt_print(halt, stderr, before);
    }
}

/* Runs the bridge in real time. An exit status. */
static int run_connected(const char *program, const options *o, ss_bridge *bridge)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_client *client = NULL;
    const softsim_client_config config = {.lcm_url = o->lcm_url,
                                          .prefix = o->prefix,
                                          .context = bridge,
                                          .handle_force = ss_bridge_take_force,
                                          .handle_status = ss_bridge_take_status,
                                          .follows_forces = true,
                                          .handle_scene = ss_bridge_take_scene};
    if (!ss_process_raise_priority()) {
        fprintf(stderr, "%s: SCHED_FIFO is not allowed here; periods may come late\n", program);
    }
    const softsim_status status = softsim_client_open(&config, &client, &error);
    if (status != SOFTSIM_OK) {
        return ss_args_finish(program, status, &error);
    }
    ss_thread_lock_memory();
    const bool is_good = ss_bridge_run(bridge, client);
    softsim_client_close(&client);
    if (!is_good) {
        fprintf(stderr, "%s: LCM failed\n", program);
    } else if (bridge->summary.forces == 0 && bridge->summary.others > 0) {
        fprintf(stderr, "%s: no force came: another sender held the probe for %.1f s\n", program,
                bridge->summary.other_s);
    } else if (bridge->summary.forces == 0) {
        ss_silence_explain(program, &config, (int32_t)o->probe, "no force came");
    } else if (ss_halt_is_seen(&bridge->summary.halt)) {
        tell_halt(program, bridge);
    } else if (o->kind->is_hand && bridge->summary.was_inside) {
        fprintf(stderr,
                "%s: the hand started inside the tissue, so its first half second was faded in; "
                "move --offset-m out along the surface's normal, or begin once the server is "
                "ready\n",
                program);
    } else if (bridge->summary.contact_ticks == 0 && bridge->summary.is_complete) {
        tell_miss(program, &config, (int32_t)o->probe, &bridge->summary);
    }
    const ss_bridge_summary *s = &bridge->summary;
    return is_good && s->forces > 0 && is_whole(s) ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* A recording has its own name only when it is complete, of one server's body, without a gap. */
static bool finish_csv(const char *program, const ss_bridge_summary *summary, ss_output *csv,
                       softsim_error *error)
{
    if (!summary->is_complete) {
        fprintf(stderr, "%s: ended before its time, after %" PRId64 " ticks\n", program,
                summary->ticks);
    }
    if (!summary->is_complete || !is_whole(summary)) {
        ss_output_keep(csv, error);
    } else {
        ss_output_commit(csv, error);
    }
    ss_args_print_error(program, error);
    return summary->is_complete && error->fault_count == 0;
}

/* Opens device and file, runs, reports. An exit status. */
static int run(const char *program, const options *o, ss_frame *frame, softsim_error *error)
{
    static ss_bridge bridge; /* large */
    ss_output csv = {0};
    ss_device device;
    const ss_device_setup setup = {1.0 / o->rate_hz, (uint64_t)o->seed};
    if (o->kind->create(&setup, &device, error) != SOFTSIM_OK) {
        ss_args_print_error(program, error);
        return SS_EXIT_BAD_INPUT;
    }
    if (o->csv != NULL && ss_output_record(&csv, o->csv, error) != SOFTSIM_OK) {
        ss_args_print_error(program, error);
        device.destroy(device.state);
        return SS_EXIT_BAD_INPUT;
    }
    ss_output_tell_kept(csv.kept, csv.temporary, program);
    if (is_auto(o) && !place_above(program, o, frame, error)) {
        ss_args_print_error(program, error);
        device.destroy(device.state);
        ss_output_abandon(&csv);
        return EXIT_FAILURE;
    }
    const ss_bridge_config config = {
        .probe = (int32_t)o->probe,
        .is_correcting = o->correct == 0,
        .damping_n_s_per_m = o->damping,
        .tick_count = tick_count(o),
        .is_endless = !o->kind->ends && tick_count(o) == INT64_MAX,
        .bus = {o->delay_ms, o->jitter_ms, o->loss, o->outlier, (uint64_t)o->seed},
        .csv = csv.file != NULL ? &csv : NULL,
        .program = program};
    if (ss_bridge_init(&bridge, &config, frame, &device, error) != SOFTSIM_OK) {
        ss_args_print_error(program, error);
        ss_output_abandon(&csv);
        return EXIT_FAILURE;
    }
    if (csv.file != NULL) {
        fputs(isnan(o->linear_tissue) ? ss_bridge_csv_server_header : ss_bridge_csv_header,
              csv.file);
        ss_output_tell(&csv, program);
    }
    int status = EXIT_SUCCESS;
    if (isnan(o->linear_tissue)) {
        status = run_connected(program, o, &bridge);
    } else {
        ss_bridge_run_linear(&bridge, o->linear_tissue, (int32_t)o->delay_ticks);
    }
    if (bridge.summary.ticks > 0) {
        report(&bridge.summary, !isnan(o->linear_tissue));
        status = finish_csv(program, &bridge.summary, &csv, error) ? status : EXIT_FAILURE;
    }
    ss_output_abandon(&csv);
    ss_bridge_fini(&bridge);
    return status;
}

int main(int argc, char **argv)
{
    options o;
    ss_frame frame;
    softsim_error error = {.status = SOFTSIM_OK};
    const char *program = program_invocation_short_name;
    ss_program_begin();
    const ss_args_result parsed = parse_options(argc, argv, &o, &error);
    if (parsed == SS_ARGS_DONE) {
        return ss_program_finish(program, EXIT_SUCCESS);
    }
    ss_frame_init(&frame, o.axes, is_auto(&o) || o.offset == NULL ? "0,0,0" : o.offset, o.scale,
                  o.force_scale, &error);
    if (error.fault_count > 0) {
        ss_args_print_error(program, &error);
        return SS_EXIT_BAD_INPUT;
    }
    ss_process_catch_stop();
    signal(SIGPIPE, SIG_IGN); /* who reads what it says may go; the hand stays */
    return ss_program_finish(program, run(program, &o, &frame, &error));
}
