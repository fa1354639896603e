/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "replay.h"

#include <inttypes.h>
#include <math.h>
#include <time.h>

#include "process.h"
#include "rt/vec.h"

static const int64_t silence_ns = 5000000000; /* without an answer: failure */
static const int64_t resend_ns = 100000000;   /* lockstep: the pose or its answer was lost */
static const int64_t drain_ns = 500000000;    /* for the last answers */
static const int64_t recent_us = 500000;      /* of the log: answered to its end */
static const int64_t pause_us = 100000;       /* of the log: longer, and it pauses */
static const double long_s = 1.0;             /* without an answer, while poses were sent */
/* Between two looks at the clock: what is longer, the machine held this program back, and an answer
 * may lie unread; it is counted as so much. */
static const int64_t look_ns = 100000000;

const char ss_replay_csv_header[] = "pose_seq,pose_utime,probe,fx,fy,fz,tx,ty,tz,depth_m,"
                                    "stiffness_n_per_m,model_age_us,flags,latency_us,"
                                    "indentation_m\n";
const char ss_replay_csv_help[] =
    "one row per force received; SI units, world frame:\n"
    "  pose_seq, pose_utime  of the pose it answers; pose_utime in us of this\n"
    "                        client's clock\n"
    "  probe                 its number\n"
    "  fx,fy,fz; tx,ty,tz    force on the hand at the tool's origin, torque about it\n"
    "  depth_m               how deep the tool is in the surface that yields to it: what\n"
    "                        is left between the two, not how far it was pressed\n"
    "  stiffness_n_per_m     felt along the normal; 0 when free or limited\n"
    "  model_age_us          of the simulation's result that was used\n"
    "  flags                 1 contact, 2 predicted, 4 limited, 8 ramping, 16 stale pose,\n"
    "                        32 another sender holds the probe, 64 model fault, 128 grasp\n"
    "  latency_us            from the pose's sending to the force's arrival\n"
    "  indentation_m         how far the tool was pressed in since it first touched, along\n"
    "                        the normal: a press of 10 mm is 0.010";

/* The clock of lcm-logger's records. */
static int64_t wall_clock_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

/* ---- answers ---- */

static void count_latency(ss_replay_statistics *statistics, int64_t latency_us)
{
    const int64_t bounded = latency_us < 0 ? 0 : latency_us;
    ++statistics->latency[bounded < SS_REPLAY_BUCKETS ? bounded : SS_REPLAY_BUCKETS - 1];
    ++statistics->latency_count;
    if (bounded > statistics->max_latency_us) {
        statistics->max_latency_us = bounded;
    }
}

int64_t ss_replay_latency(const ss_replay_statistics *statistics, double quantile)
{
    const double wanted = quantile * (double)statistics->latency_count;
    int64_t seen = 0;
    for (int32_t us = 0; us < SS_REPLAY_BUCKETS - 1; ++us) {
        seen += statistics->latency[us];
        if (seen > 0 && (double)seen >= wanted) {
            return us;
        }
    }
    return statistics->max_latency_us;
}

/* Once, at the first row or record that is lost. */
static void tell_lost(ss_replay *replay, const char *what)
{
    if (!replay->has_told_lost) {
        fprintf(stderr, "softsim-replay: %s cannot be written on; is the disk full?\n", what);
        replay->has_told_lost = true;
    }
}

static void write_row(FILE *csv, const softsim_force *force, int64_t latency_us, double indentation)
{
    fprintf(csv, "%" PRId32 ",%" PRId64 ",%" PRId32, force->pose_seq, force->pose_utime_us,
            force->probe);
    for (int i = 0; i < 3; ++i) {
        fprintf(csv, ",%.17g", force->force[i]);
    }
    for (int i = 0; i < 3; ++i) {
        fprintf(csv, ",%.17g", force->torque[i]);
    }
    fprintf(csv, ",%.17g,%.17g,%" PRId32 ",%" PRId32 ",%" PRId64 ",%.17g\n", force->depth,
            force->stiffness, force->model_age_us, force->flags, latency_us, indentation);
}

static bool is_remembered(const ss_replay *replay, int32_t seq)
{
    return seq <= replay->seq && seq > replay->seq - SS_REPLAY_SENT && seq > 0;
}

/* Of a pose that is remembered; else not finite. */
static const double *sent_position(const ss_replay *replay, int32_t seq)
{
    static const double unknown[3] = {NAN, NAN, NAN};
    return is_remembered(replay, seq) ? replay->sent_position[seq % SS_REPLAY_SENT] : unknown;
}

/* The newest pose of its probe that a force of this sender answers, and where in the log it is. */
static void note_felt(ss_replay *replay, const softsim_force *force)
{
    ss_replay_asked *asked = &replay->asked[force->probe];
    asked->felt_seq = force->pose_seq;
    if (is_remembered(replay, force->pose_seq)) {
        asked->felt_us = replay->sent_us[force->pose_seq % SS_REPLAY_SENT];
    }
}

static void note_refused(ss_replay *replay, const softsim_force *force)
{
    ++replay->statistics.other_sender;
    if (replay->refused_seq == 0) {
        replay->refused_seq = force->pose_seq;
        replay->refused_probe = force->probe;
    }
}

/* A pose is answered: was none of its probe for long, by the clock and by the log? The clock alone
 * counts a pause of the log, the log alone what a program that was held back sends at once. Forces
 * that answer older poses again come also while a server refuses what is sent. */
static void note_answer(ss_replay *replay, int32_t probe)
{
    ss_replay_asked *asked = &replay->asked[probe];
    const double waited_s = 1e-9 * (double)asked->silent_ns;
    const double sent_s = 1e-6 * (double)asked->sent_us / replay->speed;
    if (asked->is_asking && !replay->is_lockstep && replay->gap_seq == 0 &&
        fmin(waited_s, sent_s) >= long_s) {
        replay->gap_seq = asked->seq;
        replay->gap_us = asked->us;
        replay->gap_s = waited_s;
    }
    asked->is_asking = false;
}

void ss_replay_take_force(void *context, const softsim_force *force, int64_t receive_ns)
{
    ss_replay *replay = context;
    ss_replay_statistics *statistics = &replay->statistics;
    /* A stranger may send any time in this client's name: it wraps. */
    const int64_t latency_us =
        (int64_t)((uint64_t)(receive_ns / 1000) - (uint64_t)force->pose_utime_us);
    int32_t *answered = &replay->answered_seq[force->probe];
    const bool is_first =
        force->pose_seq > *answered && force->pose_seq <= replay->sent_seq[force->probe];
    if (ss_claim_take_answer(&replay->claim, force) || replay->is_over ||
        replay->sent_seq[force->probe] == 0) { /* of a probe that is not in the log */
        return;
    }
    replay->is_asking = false;
    if (is_first) {
        note_answer(replay, force->probe);
    }
    if (replay->changed_seq == 0 && softsim_client_server_changes(replay->client) > 0) {
        replay->changed_seq = force->pose_seq;
    }
    if (replay->is_lockstep && replay->changed_seq > 0) {
        return;
    }
    if (replay->record != NULL) {
        softsim_log_write_force(replay->record, wall_clock_us(),
                                softsim_client_force_channel(replay->client, force->probe), force);
        if (softsim_log_has_failed(replay->record)) {
            tell_lost(replay, softsim_log_path(replay->record));
        }
    }
    if (replay->is_lockstep && !is_first) {
        ++statistics->duplicates;
        return;
    }
    if (is_first) {
        *answered = force->pose_seq;
        ++statistics->answered;
        count_latency(statistics, latency_us);
    }
    ++statistics->forces;
    ss_halt_take_force(&replay->halt, force, is_first);
    ss_ticks_take_force(&replay->ticks, force);
    if ((force->flags & SOFTSIM_FORCE_OTHER_SENDER) != 0) {
        note_refused(replay, force);
    } else if (is_first) {
        note_felt(replay, force);
    }
    statistics->peak_force_n = fmax(statistics->peak_force_n, ss_norm3(force->force));
    if (replay->csv.file != NULL && replay->csv.reason == 0) {
        write_row(replay->csv.file, force, latency_us,
                  ss_indentation_take(&replay->indentation[force->probe], force,
                                      sent_position(replay, force->pose_seq)));
        if (!ss_output_pace(&replay->csv)) {
            tell_lost(replay, replay->csv.path);
        }
    }
}

void ss_replay_take_status(void *context, const softsim_server_status *status, int64_t receive_ns)
{
    (void)receive_ns;
    ss_replay *replay = context;
    ss_ticks_take_status(&replay->ticks, status);
    ss_halt_take_status(&replay->halt, status);
}

/* ---- sending ---- */

/* A pose of the log's time `log_us` is sent. */
static void note_asked(ss_replay *replay, int32_t channel, int64_t log_us)
{
    ss_replay_asked *asked = &replay->asked[channel];
    const int64_t since_us = log_us - asked->played_us;
    asked->sent_us += since_us < pause_us ? since_us : pause_us;
    asked->played_us = log_us;
    if (!asked->is_asking) {
        asked->is_asking = true;
        asked->sent_us = 0;
        asked->seq = replay->seq;
        asked->us = log_us;
        asked->silent_ns = 0;
    }
    if (!replay->is_asking) {
        replay->is_asking = true;
        replay->silent_ns = 0;
        replay->looked_ns = softsim_client_now_ns();
    }
}

/* Gives the pose its number and time and sends it; `log_us` is its time in the log. */
static void send_pose(ss_replay *replay, softsim_pose_event *event, int64_t log_us)
{
    const int32_t channel = event->channel_probe;
    softsim_poses_restamp(&event->pose, softsim_client_sender(replay->client), ++replay->seq);
    replay->sent_seq[channel] = replay->seq;
    event->pose.utime_us = softsim_client_now_us();
    replay->sent_us[replay->seq % SS_REPLAY_SENT] = log_us;
    ss_copy3(replay->sent_position[replay->seq % SS_REPLAY_SENT], event->pose.position);
    note_asked(replay, channel, log_us);
    softsim_client_send_pose(replay->client, &event->pose, channel);
    ++replay->statistics.poses;
    if (replay->record != NULL) {
        softsim_log_write_pose(replay->record, wall_clock_us(),
                               softsim_client_probe_channel(replay->client, channel), &event->pose);
    }
}

/* Counts the time that this program has waited for an answer; not what it was held back. */
static bool is_silent(ss_replay *replay, int64_t now_ns)
{
    const int64_t since_ns = now_ns - replay->looked_ns;
    const int64_t waited_ns = since_ns < look_ns ? since_ns : look_ns;
    replay->looked_ns = now_ns;
    replay->silent_ns += waited_ns;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        replay->asked[p].silent_ns += waited_ns;
    }
    return replay->is_asking && replay->silent_ns > silence_ns;
}

/* Takes answers until `deadline_ns`, or until `channel` (-1: none) has all its poses answered. */
static ss_replay_result wait_until(ss_replay *replay, int64_t deadline_ns, int32_t channel)
{
    for (;;) {
        const int64_t look_at_ns = softsim_client_now_ns() + look_ns / 2;
        if (softsim_client_wait(replay->client,
                                look_at_ns < deadline_ns ? look_at_ns : deadline_ns) < 0) {
            return SS_REPLAY_BROKEN;
        }
        if (ss_process_is_stopped()) {
            return SS_REPLAY_STOPPED;
        }
        if (replay->is_lockstep && replay->changed_seq > 0) {
            return SS_REPLAY_CHANGED;
        }
        replay->has_heard_two = replay->has_heard_two || softsim_client_hears_two(replay->client);
        const int64_t now_ns = softsim_client_now_ns();
        if (is_silent(replay, now_ns)) {
            return SS_REPLAY_SILENT;
        }
        if (channel >= 0 && replay->answered_seq[channel] == replay->sent_seq[channel]) {
            return SS_REPLAY_DONE;
        }
        if (now_ns >= deadline_ns) {
            return SS_REPLAY_DONE;
        }
    }
}

static ss_replay_result play_locked(ss_replay *replay, softsim_pose_event *event, int64_t log_us)
{
    const int32_t channel = event->channel_probe;
    send_pose(replay, event, log_us);
    for (;;) {
        const ss_replay_result result =
            wait_until(replay, softsim_client_now_ns() + resend_ns, channel);
        if (result != SS_REPLAY_DONE ||
            replay->answered_seq[channel] == replay->sent_seq[channel]) {
            return result;
        }
        /* The same message again: a server that has answered it repeats its answer. */
        softsim_client_send_pose(replay->client, &event->pose, channel);
        ++replay->statistics.resent;
    }
}

static bool has_ended_unanswered(const ss_replay_asked *asked)
{
    return asked->is_asking && asked->felt_seq > 0 && asked->sent_us > recent_us;
}

int32_t ss_replay_ended_unanswered(const ss_replay *replay)
{
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (has_ended_unanswered(&replay->asked[p])) {
            return p;
        }
    }
    return -1;
}

int32_t ss_replay_never_answered(const ss_replay *replay)
{
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (replay->statistics.answered > 0 && replay->sent_seq[p] > 0 &&
            replay->answered_seq[p] == 0) {
            return p;
        }
    }
    return -1;
}

/* Is there a probe whose answers may still come, though late? */
static bool may_be_late(const ss_replay *replay)
{
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        const ss_replay_asked *asked = &replay->asked[p];
        if (has_ended_unanswered(asked) && asked->silent_ns <= silence_ns) {
            return true;
        }
    }
    return false;
}

/* Waits until the last pose of every channel is answered, for a while; for a server that has
 * answered before and is behind, until it is heard or taken for silent. */
static ss_replay_result drain(ss_replay *replay)
{
    const int64_t deadline_ns = softsim_client_now_ns() + drain_ns;
    ss_replay_result result = SS_REPLAY_DONE;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES && result == SS_REPLAY_DONE; ++p) {
        result = wait_until(replay, deadline_ns, p);
    }
    while (result == SS_REPLAY_DONE && may_be_late(replay)) {
        result = wait_until(replay, softsim_client_now_ns() + look_ns, -1);
    }
    return result == SS_REPLAY_SILENT ? SS_REPLAY_DONE : result; /* all is played */
}

/* What a wait that went on, or did not, means. */
static ss_replay_result result_of(bool is_connected)
{
    return !is_connected             ? SS_REPLAY_BROKEN
           : ss_process_is_stopped() ? SS_REPLAY_STOPPED
                                     : SS_REPLAY_DONE;
}

/* The next pose is so late. What comes at once, from one pose to the next, is no slow machine's. */
static void note_late(ss_replay *replay, int64_t late_ns)
{
    const double held_s = 1e-9 * (double)(late_ns - replay->late_ns);
    replay->late_ns = late_ns;
    if (held_s >= long_s && replay->held_seq == 0) {
        replay->held_seq = replay->seq + 1;
        replay->held_s = held_s;
    }
}

/* Plays the whole log so many times. */
static ss_replay_result play(ss_replay *replay)
{
    const int64_t start_ns = softsim_client_now_ns();
    ss_replay_result result = SS_REPLAY_DONE;
    int64_t turn_us = 0; /* log time at which this turn starts */
    for (int64_t turn = 0; turn < replay->repeat && result == SS_REPLAY_DONE; ++turn) {
        int64_t last_us = turn_us;
        softsim_poses_rewind(replay->poses);
        while (result == SS_REPLAY_DONE) {
            softsim_pose_event event;
            char note[256]; /* said once already, when the log was looked through */
            const softsim_poses_result next =
                softsim_poses_next(replay->poses, &event, note, sizeof note);
            if (next == SOFTSIM_POSES_END) {
                break;
            }
            if (next == SOFTSIM_POSES_NOTE) {
                continue;
            }
            last_us = turn_us + event.time_us;
            if (replay->is_lockstep) {
                result = play_locked(replay, &event, last_us);
                continue;
            }
            const double elapsed_ns = 1e3 * (double)last_us / replay->speed;
            const int64_t due_ns = start_ns + (int64_t)elapsed_ns;
            result = wait_until(replay, due_ns, -1);
            if (result == SS_REPLAY_DONE) {
                note_late(replay, softsim_client_now_ns() - due_ns);
                send_pose(replay, &event, last_us);
            }
        }
        turn_us = last_us + replay->repeat_gap_us;
    }
    return result;
}

static ss_replay_result play_in_lockstep(ss_replay *replay)
{
    ss_ticks *ticks = &replay->ticks;
    ss_replay_result result = result_of(ss_ticks_ask(ticks, replay->client));
    const bool is_told = ticks->statuses > 0, is_counted = ticks->is_counted;
    const int64_t before = ticks->count;
    result = result == SS_REPLAY_DONE ? play(replay) : result;
    if (result == SS_REPLAY_DONE && is_told) {
        /* All is played, be it stopped now. */
        result = ss_ticks_ask(ticks, replay->client) ? SS_REPLAY_DONE : SS_REPLAY_BROKEN;
        const int64_t others = ticks->count - before - replay->statistics.poses;
        replay->is_uncounted = !is_counted || !ticks->is_counted || others < 0;
        replay->statistics.other_ticks = replay->is_uncounted ? 0 : others;
    }
    return result;
}

static ss_replay_result play_paced(ss_replay *replay)
{
    ss_replay_result result =
        result_of(ss_claim_wait(&replay->claim, replay->client, replay->poses, replay->speed));
    if (result == SS_REPLAY_DONE && ss_claim_held(&replay->claim) >= 0) {
        return SS_REPLAY_HELD;
    }
    result = result == SS_REPLAY_DONE ? play(replay) : result;
    return result == SS_REPLAY_DONE ? drain(replay) : result;
}

ss_replay_result ss_replay_run(ss_replay *replay)
{
    const ss_replay_result result =
        replay->is_lockstep ? play_in_lockstep(replay) : play_paced(replay);
    replay->is_over = true;
    if (result == SS_REPLAY_DONE) {
        ss_halt_ask(&replay->halt, replay->client);
    }
    return result;
}
