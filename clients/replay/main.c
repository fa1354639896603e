/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-replay: options, the look through the log beforehand, and the report afterwards. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "process.h"
#include "replay.h"
#include "rt/args.h"
#include "rt/files.h"
#include "rt/plain.h"
#include "rt/program.h"
#include "silence.h"
#include "softsim/client.h"
#include "softsim/log.h"

enum { MAX_NOTES = 20 };

typedef struct options {
    const char *lcm_url, *prefix, *record, *csv;
    double rate_hz, speed;
    int64_t repeat;
    bool is_lockstep, is_convert;
    const char *input, *output;
} options;

/* What the log holds. */
typedef struct survey {
    int64_t poses, notes, duration_us;
    int32_t probe_count;
    bool is_damaged, is_mixed;
} survey;

static const char usage[] = "[options] LOG|CSV   or   --convert [options] CSV OUT.lcmlog";
static const char about[] =
    "Plays the probe poses of an LCM event log, or of a pose CSV\n"
    "(time_s,probe,x,y,z,qw,qx,qy,qz,buttons), to a softsimd and keeps the answers.";

static ss_args_result parse_options(int argc, char **argv, options *o, softsim_error *error)
{
    *o = (options){.rate_hz = 1000.0, .speed = 1.0, .repeat = 1};
    const ss_arg rows[] = {
        SS_FLAG("--lockstep", &o->is_lockstep,
                "wait for each pose's answer before the next (server with --lockstep)"),
        {"--speed", SS_ARG_NUMBER, &o->speed, 1e-3, 1e3, "X", "times as fast as recorded (1)"},
        {"--repeat", SS_ARG_INTEGER, &o->repeat, 1, 1e6, "N", "play N times (1)"},
        {"--rate", SS_ARG_NUMBER, &o->rate_hz, 1, 1e4, "HZ", "at which a CSV is sampled (1000)"},
        SS_TEXT("--csv", &o->csv, "OUT.csv", ss_replay_csv_help),
        SS_TEXT("--record", &o->record, "OUT.lcmlog",
                "event log of the poses sent and the forces received; like --csv written to\n"
                "OUT.part once a second, and OUT at the end of a replay that exits 0: one\n"
                "server, neither paused nor at fault, felt the whole log, which had no damage\n"
                "but a cut end, and nothing else moved its time"),
        SS_FLAG("--convert", &o->is_convert,
                "write the poses as an event log instead of playing them; of a damaged log what\n"
                "is left, in OUT.part, exit 1"),
        SS_ARG_BUS(&o->lcm_url, &o->prefix),
    };
    const char *positional[2] = {NULL, NULL};
    int32_t count = 0;
    const ss_args_result result =
        ss_args_parse(argc, argv, usage, about, rows, (int32_t)(sizeof rows / sizeof rows[0]),
                      positional, 1, 2, &count, error);
    if (result != SS_ARGS_RUN) {
        return result;
    }
    if (count != (o->is_convert ? 2 : 1)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "%s",
                          o->is_convert ? "--convert needs two files: CSV OUT.lcmlog"
                                        : "only --convert takes a second file");
    }
    if (o->is_lockstep && o->speed != 1.0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--speed: in --lockstep the answers set the pace; leave it out");
    }
    o->input = positional[0];
    o->output = positional[1];
    const ss_named_file in = {"the file played", o->input};
    const ss_named_file out[] = {
        {"--convert", o->output}, {"--record", o->record}, {"--csv", o->csv}};
    if (error->fault_count == 0) {
        (void)ss_files_check(&in, 1, out, 3, error);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : result;
}

/* Reads the whole log once: says what is damaged, counts poses and probes. */
static survey look_through(const char *program, const char *path, softsim_poses *poses)
{
    survey found = {0};
    uint32_t probes = 0;
    for (;;) {
        softsim_pose_event event;
        char note[256];
        const softsim_poses_result next = softsim_poses_next(poses, &event, note, sizeof note);
        if (next == SOFTSIM_POSES_END) {
            break;
        }
        if (next == SOFTSIM_POSES_NOTE) {
            if (found.notes++ < MAX_NOTES) {
                ss_plain_print(stderr, "%s: %s: %s\n", program, path, note);
            }
            continue;
        }
        ++found.poses;
        probes |= 1u << event.channel_probe;
        found.duration_us = event.time_us;
    }
    if (found.notes > MAX_NOTES) {
        ss_plain_print(stderr, "%s: %s: and %" PRId64 " more\n", program, path,
                       found.notes - MAX_NOTES);
    }
    found.is_damaged = softsim_poses_is_damaged(poses);
    found.is_mixed = softsim_poses_is_mixed(poses);
    found.probe_count = __builtin_popcount(probes);
    return found;
}

static void tell_kept_log(const char *program, const softsim_log_writer *writer)
{
    ss_output_tell_kept(softsim_log_kept(writer), softsim_log_path(writer), program);
}

/* What keeps a log from being one hand's, whole; whether there is such a thing. */
static bool tell_damage(const char *program, const options *o, const survey *found)
{
    const char *done = o->is_convert ? "converted" : "played";
    if (found->is_damaged) {
        ss_plain_print(stderr, "%s: %s: records are missing; what is left was %s\n", program,
                       o->input, done);
    }
    if (found->is_mixed) {
        ss_plain_print(stderr, "%s: %s: poses of two senders are mixed; all of them were %s\n",
                       program, o->input, done);
    }
    return found->is_damaged || found->is_mixed;
}

/* Writes the poses as a log: times from 0, sender 1, so that equal input gives equal bytes. */
static int convert(const char *program, const options *o, softsim_poses *poses, const survey *found)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    if (softsim_log_create(o->output, &writer, &error) != SOFTSIM_OK) {
        ss_args_print_error(program, &error);
        return SS_EXIT_BAD_INPUT;
    }
    tell_kept_log(program, writer);
    const char *prefix = o->prefix != NULL ? o->prefix : SOFTSIM_DEFAULT_PREFIX;
    softsim_pose_event event;
    char note[256];
    int32_t seq = 0;
    softsim_poses_result next;
    softsim_poses_rewind(poses);
    while (!ss_process_is_stopped() &&
           (next = softsim_poses_next(poses, &event, note, sizeof note)) != SOFTSIM_POSES_END) {
        if (next == SOFTSIM_POSES_POSE) {
            char channel[SOFTSIM_LOG_CHANNEL_SIZE];
            snprintf(channel, sizeof channel, "%.50s_PROBE_%" PRId32, prefix, event.channel_probe);
            softsim_poses_restamp(&event.pose, 1, ++seq);
            event.pose.utime_us = event.time_us;
            softsim_log_write_pose(writer, event.time_us, channel, &event.pose);
        }
    }
    const bool is_whole = !tell_damage(program, o, found);
    if (ss_process_is_stopped() || !is_whole) {
        softsim_log_keep(&writer, &error);
    } else {
        softsim_log_finish(&writer, &error);
    }
    ss_args_print_error(program, &error);
    return error.fault_count == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

static void report(const ss_replay *replay, const survey *found)
{
    const ss_replay_statistics *s = &replay->statistics;
    const softsim_client_counts counts = softsim_client_read_counts(replay->client);
    printf("poses       %" PRId64 " sent, %" PRId64 " answered, %" PRId64 " missing answers\n",
           s->poses, s->answered, s->poses - s->answered);
    printf("forces      %" PRId64 " received, peak %.6g N\n", s->forces, s->peak_force_n);
    printf("latency_us  p50 %" PRId64 " p99 %" PRId64 " max %" PRId64 "\n",
           ss_replay_latency(s, 0.5), ss_replay_latency(s, 0.99), s->max_latency_us);
    printf("log         %" PRId64 " poses, %" PRId64 " damaged or skipped records\n", found->poses,
           found->notes);
    if (replay->is_lockstep) {
        printf("lockstep    %" PRId64 " poses sent again, %" PRId64 " repeated answers\n",
               s->resent, s->duplicates);
    }
    if (s->other_sender > 0) {
        printf("refused     %" PRId64 " forces say that another sender holds the probe\n",
               s->other_sender);
    }
    if (counts.malformed > 0 || counts.unsent > 0) {
        printf("network     %" PRId64 " malformed messages, %" PRId64 " poses not sent\n",
               counts.malformed, counts.unsent);
    }
}

/* A recording has its own name only when it is complete: one server's answers to the whole log. */
static bool finish_files(const char *program, ss_replay *replay, bool is_complete)
{
    softsim_error error = {.status = SOFTSIM_OK};
    if (is_complete) {
        softsim_log_finish(&replay->record, &error);
        ss_output_commit(&replay->csv, &error);
    } else {
        softsim_log_keep(&replay->record, &error);
        ss_output_keep(&replay->csv, &error);
    }
    ss_args_print_error(program, &error);
    return error.fault_count == 0;
}

/* Opens files and network; nothing is left open after a failure. */
static softsim_status open_all(const char *program, const options *o,
                               const softsim_client_config *config, ss_replay *replay,
                               softsim_error *error)
{
    softsim_status status = SOFTSIM_OK;
    if (o->record != NULL) {
        status = softsim_log_create(o->record, &replay->record, error);
    }
    if (replay->record != NULL) {
        tell_kept_log(program, replay->record);
    }
    if (status == SOFTSIM_OK && o->csv != NULL) {
        status = ss_output_record(&replay->csv, o->csv, error);
        ss_output_tell_kept(replay->csv.kept, replay->csv.temporary, program);
    }
    if (status == SOFTSIM_OK) {
        status = softsim_client_open(config, &replay->client, error);
    }
    if (status != SOFTSIM_OK) {
        softsim_log_abandon(&replay->record);
        ss_output_abandon(&replay->csv);
        softsim_client_close(&replay->client);
        return status;
    }
    if (replay->csv.file != NULL) {
        fputs(ss_replay_csv_header, replay->csv.file);
        ss_output_tell(&replay->csv, program);
    }
    if (replay->record != NULL) {
        ss_plain_print(stderr, "%s: recording to %s; at the end it becomes %s\n", program,
                       softsim_log_path(replay->record), o->record);
    }
    return SOFTSIM_OK;
}

/* Says on stderr why not all was played. */
static void tell_result(const char *program, const options *o, const ss_replay *replay,
                        const survey *found, ss_replay_result result)
{
    if (result == SS_REPLAY_SILENT) {
        fprintf(stderr,
                "%s: no answer for 5 s after pose %" PRId32
                "; is softsimd running, with this prefix and LCM url%s?\n",
                program, replay->seq, o->is_lockstep ? ", with --lockstep" : "");
    } else if (result == SS_REPLAY_STOPPED) {
        fprintf(stderr, "%s: stopped after %" PRId64 " of %" PRId64 " poses\n", program,
                replay->statistics.poses, found->poses * o->repeat);
    } else if (result == SS_REPLAY_HELD) {
        fprintf(stderr, "%s: another sender still holds probe %" PRId32 ": nothing was played\n",
                program, ss_claim_held(&replay->claim));
    } else if (result == SS_REPLAY_BROKEN) {
        fprintf(stderr, "%s: LCM failed\n", program);
    }
}

/* Of a probe whose answers stopped before the log's end, or never came; whether there was one. */
static bool tell_unanswered(const char *program, const ss_replay *replay)
{
    const int32_t cut = ss_replay_ended_unanswered(replay);
    if (cut >= 0) {
        const ss_replay_asked *asked = &replay->asked[cut];
        fprintf(stderr,
                "%s: answers stopped at pose %" PRId32 " of probe %" PRId32
                " (%.3f s of %.3f s): has softsimd ended?\n",
                program, asked->felt_seq, cut, 1e-6 * (double)asked->felt_us,
                1e-6 * (double)asked->played_us);
    }
    const int32_t mute = ss_replay_never_answered(replay);
    if (mute >= 0) {
        fprintf(stderr,
                "%s: no answer to any pose of probe %" PRId32 ": has the scene a tool for it?\n",
                program, mute);
    }
    return cut >= 0 || mute >= 0;
}

/* Says on stderr what makes the answers others than those of one server to the whole log; whether
 * there was such a thing. */
static bool tell_doubt(const char *program, const ss_replay *replay, ss_replay_result result)
{
    char before[64];
    snprintf(before, sizeof before, "%.40s: ", program);
    ss_halt_print(&replay->halt, stderr, before);
    if (replay->changed_seq > 0) {
        fprintf(stderr,
                "%s: another server answers since pose %" PRId32
                ": its body has felt nothing of the poses before; play them again\n",
                program, replay->changed_seq);
    }
    if (replay->refused_seq > 0) {
        fprintf(stderr,
                "%s: another sender held probe %" PRId32 " at pose %" PRId32
                ": what was refused is not felt; play the log again\n",
                program, replay->refused_probe, replay->refused_seq);
    }
    if (replay->gap_seq > 0) {
        fprintf(stderr,
                "%s: no answer for %.1f s from pose %" PRId32
                " on (%.3f s of the log): what was sent meanwhile is not felt; play it again\n",
                program, replay->gap_s, replay->gap_seq, 1e-6 * (double)replay->gap_us);
    }
    if (replay->is_uncounted) {
        fprintf(stderr,
                "%s: whose ticks they were is not known: the server's count of poses was not "
                "heard; play it again\n",
                program);
    }
    if (replay->held_seq > 0) {
        fprintf(stderr,
                "%s: this program was held up for %.1f s at pose %" PRId32
                ": what was sent in a burst is not felt one by one; play it again\n",
                program, replay->held_s, replay->held_seq);
    }
    if (replay->statistics.other_ticks > 0) {
        fprintf(
            stderr,
            "%s: poses of other senders made %" PRId64
            " ticks meanwhile: the forces are not the log's alone; play it again without them\n",
            program, replay->statistics.other_ticks);
    }
    const bool is_unanswered = result == SS_REPLAY_DONE && tell_unanswered(program, replay);
    return replay->changed_seq > 0 || replay->refused_seq > 0 || replay->gap_seq > 0 ||
           replay->held_seq > 0 || replay->statistics.other_ticks > 0 || replay->is_uncounted ||
           is_unanswered || ss_halt_is_seen(&replay->halt);
}

/* Plays, reports, closes. */
static int play(const char *program, const options *o, softsim_poses *poses, const survey *found)
{
    static ss_replay replay; /* large */
    softsim_error error = {.status = SOFTSIM_OK};
    replay.poses = poses;
    replay.speed = o->speed;
    replay.repeat = o->repeat;
    replay.repeat_gap_us = (int64_t)(1e6 / o->rate_hz);
    replay.is_lockstep = o->is_lockstep;
    const softsim_client_config config = {.lcm_url = o->lcm_url,
                                          .prefix = o->prefix,
                                          .context = &replay,
                                          .handle_force = ss_replay_take_force,
                                          .handle_status = ss_replay_take_status,
                                          .follows_forces = !o->is_lockstep};
    if (!o->is_lockstep) {
        ss_process_raise_priority(); /* better pacing; does without where it is not allowed */
    }
    const softsim_status status = open_all(program, o, &config, &replay, &error);
    if (status != SOFTSIM_OK) {
        ss_args_print_error(program, &error);
        return status == SOFTSIM_ERROR_ARGUMENT || status == SOFTSIM_ERROR_FILE ? SS_EXIT_BAD_INPUT
                                                                                : EXIT_FAILURE;
    }
    if (o->is_lockstep && found->probe_count > 1) {
        fprintf(stderr,
                "%s: %" PRId32 " probes: in lockstep every pose is a tick, so a log at the tick "
                "rate plays %" PRId32 " times slower in simulated time\n",
                program, found->probe_count, found->probe_count);
    }
    const ss_replay_result result = ss_replay_run(&replay);
    tell_result(program, o, &replay, found, result);
    const bool is_answered = replay.statistics.forces > replay.statistics.other_sender;
    const bool is_one =
        !ss_process_tell_two(program, "the first one's answers are kept", replay.has_heard_two);
    const bool is_doubtful = tell_doubt(program, &replay, result);
    const bool is_whole = !tell_damage(program, o, found);
    const bool is_good =
        result == SS_REPLAY_DONE && is_answered && is_one && !is_doubtful && is_whole;
    const bool is_written = finish_files(program, &replay, is_good);
    report(&replay, found);
    softsim_client_close(&replay.client);
    if (result == SS_REPLAY_DONE && !is_answered && replay.refused_seq == 0) {
        ss_silence_explain(program, &config, -1, "no answer came");
    }
    return is_good && is_written ? EXIT_SUCCESS : EXIT_FAILURE;
}

int main(int argc, char **argv)
{
    const char *program = program_invocation_short_name;
    options o;
    softsim_error error = {.status = SOFTSIM_OK};
    ss_program_begin();
    const ss_args_result parsed = parse_options(argc, argv, &o, &error);
    if (parsed == SS_ARGS_DONE) {
        return ss_program_finish(program, EXIT_SUCCESS);
    }
    softsim_poses *poses = NULL;
    if (parsed == SS_ARGS_BAD ||
        softsim_poses_open(o.input, o.rate_hz, &poses, &error) != SOFTSIM_OK) {
        ss_args_print_error(program, &error);
        return SS_EXIT_BAD_INPUT;
    }
    const survey found = look_through(program, o.input, poses);
    ss_process_catch_stop(); /* nothing is lost when a long look is simply ended */
    int status = SS_EXIT_BAD_INPUT;
    if (found.poses == 0) {
        ss_plain_print(stderr, "%s: %s: no probe poses: no record on a channel ..._PROBE_<n>\n",
                       program, o.input);
    } else if (found.poses > INT32_MAX / o.repeat) {
        fprintf(stderr, "%s: --repeat: more poses than a seq can number\n", program);
    } else {
        status =
            o.is_convert ? convert(program, &o, poses, &found) : play(program, &o, poses, &found);
    }
    softsim_poses_close(&poses);
    return ss_program_finish(program, status);
}
