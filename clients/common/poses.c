/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Poses from an event log or a pose CSV, as one sequence.
 *
 * The time of a log's pose is the logger's receipt of it: that is the one clock that all senders
 * of a log share. It is made never to decrease. Poses of several senders may be a little out of
 * order, since the kernel stamps each packet on its way in: one that is back by no more than
 * max_crossing_us has the time of the newest before it. A step further back, or of more than
 * max_gap_us (a log put together from several, a clock that was set), counts as none and is noted,
 * so that no player waits for it.
 *
 * A log of a session may hold poses of several senders on one probe, of which the server took
 * one's: the log is looked through once beforehand for the forces that tell (refusals.h), and
 * again, where there are others, for poses that would be mixed.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "net/codec.h"
#include "refusals.h"
#include "rt/files.h"
#include "rt/vec.h"
#include "softsim/log.h"

static const int64_t max_gap_us = 60 * 1000 * 1000;
static const int64_t max_crossing_us = 100 * 1000;
static const int64_t hold_us = 500 * 1000; /* a server's, after a sender's last pose */

struct softsim_poses {
    softsim_log *log; /* one of the two */
    softsim_path *path;

    /* Of a log: the time of its newest pose. */
    bool has_time;
    int64_t log_utime_us, time_us;
    bool is_damaged;
    bool has_pending; /* a pose that waits behind a note */
    softsim_pose_event pending;

    /* Of a log: poses of several senders. */
    ss_refusals refusals;
    int64_t refused_count, question_count; /* that are left out */
    int32_t mixed_probe;                   /* of the first pose that is mixed with another's, */
    int64_t mixed_offset;                  /* and its byte; -1: none is */
    bool has_told_left_out, has_told_mixed;

    /* Of a CSV: the sample grid. */
    double rate_hz;
    int64_t first_sample, sample, sample_end;
    int32_t probe; /* the next at this sample */
    bool has_told_cut;
};

static bool ends_with(const char *text, const char *end)
{
    const size_t a = strlen(text);
    const size_t b = strlen(end);
    return a >= b && strcmp(text + a - b, end) == 0;
}

static bool is_csv(const char *path)
{
    char head[6] = {0};
    const char *why = NULL;
    FILE *file = ss_files_open_stream(path, NULL, &why); /* what reads the file names the fault */
    if (file != NULL) {
        if (fread(head, 1, sizeof head, file) != sizeof head) {
            head[0] = '\0';
        }
        fclose(file);
    }
    return memcmp(head, "time_s", sizeof head) == 0 || memcmp(head, "tick,x", sizeof head) == 0 ||
           ends_with(path, ".csv");
}

/* ---- poses of several senders ---- */

/* Numbered 0 are those that ask whose a probe is, before a replay begins. */
static bool is_left_out(softsim_poses *poses, const softsim_pose *pose, int32_t probe)
{
    return pose->seq == 0 || (poses->refusals.has_refused &&
                              ss_refusals_of(&poses->refusals, pose, probe) == SS_REFUSALS_REFUSED);
}

/* Reads all forces; are there poses that are left out, or several senders? */
static bool find_refusals(softsim_poses *poses)
{
    bool has_pose[SOFTSIM_MAX_PROBES] = {false}, is_needed = false;
    int64_t sender[SOFTSIM_MAX_PROBES];
    softsim_log_event event;
    softsim_log_result result;
    while ((result = softsim_log_next(poses->log, &event)) != SOFTSIM_LOG_END) {
        const int32_t probe = result == SOFTSIM_LOG_EVENT ? softsim_log_probe(event.channel) : -1;
        softsim_pose pose;
        softsim_force force;
        if (probe >= 0 && softsim_log_decode_pose(event.data, event.data_size, &pose)) {
            is_needed =
                is_needed || pose.seq == 0 || (has_pose[probe] && pose.sender != sender[probe]);
            has_pose[probe] = true;
            sender[probe] = pose.sender;
        } else if (result == SOFTSIM_LOG_EVENT && probe < 0 &&
                   softsim_log_decode_force(event.data, event.data_size, &force) &&
                   force.probe >= 0 && force.probe < SOFTSIM_MAX_PROBES) {
            ss_refusals_note(&poses->refusals, &force);
        }
    }
    return is_needed || poses->refusals.has_refused;
}

/* Counts what is left out of a log, and finds what is left of two senders at once: one that no
 * force answers within the time in which a server holds a probe for the other. */
static void find_mixed(softsim_poses *poses)
{
    struct {
        bool is_there, is_told;
        int64_t sender, utime_us;
    } last[SOFTSIM_MAX_PROBES] = {{false, false, 0, 0}};
    softsim_log_event event;
    softsim_log_result result;
    softsim_log_rewind(poses->log);
    while ((result = softsim_log_next(poses->log, &event)) != SOFTSIM_LOG_END) {
        const int32_t p = result == SOFTSIM_LOG_EVENT ? softsim_log_probe(event.channel) : -1;
        softsim_pose pose;
        if (p < 0 || !softsim_log_decode_pose(event.data, event.data_size, &pose)) {
            continue;
        }
        if (is_left_out(poses, &pose, p)) {
            ++*(pose.seq == 0 ? &poses->question_count : &poses->refused_count);
            continue;
        }
        const bool is_told = ss_refusals_of(&poses->refusals, &pose, p) != SS_REFUSALS_UNTOLD;
        const bool is_changed = last[p].is_there && last[p].sender != pose.sender;
        const bool is_clear = is_told && last[p].is_told && !poses->refusals.is_full;
        /* Unsigned, as in advance_time. */
        const uint64_t step = (uint64_t)event.utime_us - (uint64_t)last[p].utime_us;
        const bool is_close = step < (uint64_t)hold_us || 0 - step < (uint64_t)hold_us;
        if (is_changed && is_close && !is_clear && poses->mixed_offset < 0) {
            poses->mixed_probe = p;
            poses->mixed_offset = event.offset;
        }
        last[p].is_there = true;
        last[p].is_told = is_told;
        last[p].sender = pose.sender;
        last[p].utime_us = event.utime_us;
    }
}

softsim_status softsim_poses_open(const char *path, double rate_hz, softsim_poses **out_poses,
                                  softsim_error *error)
{
    *out_poses = NULL;
    softsim_poses *poses = calloc(1, sizeof *poses);
    if (poses == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", path);
        return SOFTSIM_ERROR_MEMORY;
    }
    softsim_status status;
    poses->mixed_offset = -1;
    if (is_csv(path)) {
        status = softsim_path_load(path, &poses->path, error);
        if (status == SOFTSIM_OK) {
            double begin_s = 0.0;
            double end_s = 0.0;
            softsim_path_range(poses->path, -1, &begin_s, &end_s);
            /* A time written in decimals may miss its tick by rounding: a thousandth is allowed. */
            poses->rate_hz = rate_hz;
            poses->first_sample = (int64_t)ceil(begin_s * rate_hz - 1e-3);
            poses->sample_end = (int64_t)floor(end_s * rate_hz + 1e-3) + 1;
        }
    } else {
        status = softsim_log_open(path, &poses->log, error);
    }
    if (status != SOFTSIM_OK) {
        free(poses);
        return status;
    }
    if (poses->log != NULL && find_refusals(poses)) {
        find_mixed(poses);
    }
    softsim_poses_rewind(poses);
    *out_poses = poses;
    return SOFTSIM_OK;
}

void softsim_poses_close(softsim_poses **poses)
{
    if (*poses != NULL) {
        softsim_log_close(&(*poses)->log);
        softsim_path_free(&(*poses)->path);
        free(*poses);
        *poses = NULL;
    }
}

void softsim_poses_rewind(softsim_poses *poses)
{
    if (poses->log != NULL) {
        softsim_log_rewind(poses->log);
    }
    poses->has_time = false;
    poses->has_pending = false;
    poses->time_us = 0;
    poses->sample = poses->first_sample;
    poses->probe = 0;
    poses->has_told_cut = false;
    poses->has_told_left_out = false;
    poses->has_told_mixed = false;
}

/* ---- CSV ---- */

static softsim_poses_result next_of_path(softsim_poses *poses, softsim_pose_event *out, char *note,
                                         size_t note_size)
{
    double begin_s = 0.0;
    double end_s = 0.0;
    softsim_path_range(poses->path, -1, &begin_s, &end_s);
    while (poses->sample < poses->sample_end) {
        const double time_s = (double)poses->sample / poses->rate_hz;
        const double inside_s = fmin(fmax(time_s, begin_s), end_s); /* within rounding of a row */
        while (poses->probe < SOFTSIM_MAX_PROBES) {
            const int32_t probe = poses->probe++;
            if (softsim_path_sample(poses->path, probe, inside_s, &out->pose)) {
                const int64_t ticks = poses->sample - poses->first_sample;
                out->channel_probe = probe;
                out->time_us = llround((double)ticks * 1e6 / poses->rate_hz);
                return SOFTSIM_POSES_POSE;
            }
        }
        poses->probe = 0;
        ++poses->sample;
    }
    if (!poses->has_told_cut && softsim_path_note(poses->path, note, note_size)) {
        poses->has_told_cut = true;
        return SOFTSIM_POSES_NOTE;
    }
    return SOFTSIM_POSES_END;
}

/* ---- log ---- */

/* Moves the time on to the event; true when the step was not taken. */
static bool advance_time(softsim_poses *poses, int64_t utime_us)
{
    /* Unsigned, because two hostile times may be further apart than int64 reaches. */
    const uint64_t step = (uint64_t)utime_us - (uint64_t)poses->log_utime_us;
    const bool is_back = poses->has_time && utime_us < poses->log_utime_us;
    if (is_back && 0 - step <= (uint64_t)max_crossing_us) {
        return false;
    }
    const bool is_odd = poses->has_time && (is_back || step > (uint64_t)max_gap_us);
    if (poses->has_time && !is_odd) {
        poses->time_us += (int64_t)step;
    }
    poses->has_time = true;
    poses->log_utime_us = utime_us;
    return is_odd;
}

/* At the log's end. */
static softsim_poses_result tell_senders(softsim_poses *poses, char *note, size_t note_size)
{
    if (!poses->has_told_left_out && poses->refused_count + poses->question_count > 0) {
        poses->has_told_left_out = true;
        snprintf(note, note_size,
                 "left out %" PRId64
                 " poses that were refused since another sender held the probe, "
                 "and %" PRId64 " numbered 0, which ask for it",
                 poses->refused_count, poses->question_count);
        return SOFTSIM_POSES_NOTE;
    }
    if (!poses->has_told_mixed && poses->mixed_offset >= 0) {
        poses->has_told_mixed = true;
        snprintf(note, note_size,
                 "poses of two senders on probe %" PRId32 " at byte %" PRId64
                 ", within half a second, and no force of the log tells whose were taken",
                 poses->mixed_probe, poses->mixed_offset);
        return SOFTSIM_POSES_NOTE;
    }
    return SOFTSIM_POSES_END;
}

static softsim_poses_result next_of_log(softsim_poses *poses, softsim_pose_event *out, char *note,
                                        size_t note_size)
{
    if (poses->has_pending) {
        poses->has_pending = false;
        *out = poses->pending;
        return SOFTSIM_POSES_POSE;
    }
    softsim_log_event event;
    for (;;) {
        switch (softsim_log_next(poses->log, &event)) {
        case SOFTSIM_LOG_END:
            return tell_senders(poses, note, note_size);
        case SOFTSIM_LOG_DAMAGED:
            poses->is_damaged = true;
            snprintf(note, note_size,
                     "damaged record at byte %" PRId64 ", skipped %" PRId64 " bytes", event.offset,
                     event.skipped);
            return SOFTSIM_POSES_NOTE;
        case SOFTSIM_LOG_TRUNCATED:
            snprintf(note, note_size,
                     "truncated record at byte %" PRId64 ", skipped the last %" PRId64 " bytes",
                     event.offset, event.skipped);
            return SOFTSIM_POSES_NOTE;
        case SOFTSIM_LOG_UNREADABLE:
            poses->is_damaged = true;
            snprintf(note, note_size, "cannot read on at byte %" PRId64 ", the rest is left out",
                     event.offset);
            return SOFTSIM_POSES_NOTE;
        case SOFTSIM_LOG_EVENT:
            break;
        }
        const int32_t probe = softsim_log_probe(event.channel);
        if (probe < 0) {
            continue; /* other messages of the session */
        }
        if (!softsim_log_decode_pose(event.data, event.data_size, &out->pose)) {
            /* Of another size it is another's message, and was no pose when it was sent. */
            poses->is_damaged |= event.data_size == SS_WIRE_POSE_SIZE;
            snprintf(note, note_size,
                     "record at byte %" PRId64 " on %s is no probe_pose_t (%" PRId32
                     " bytes), skipped",
                     event.offset, event.channel, event.data_size);
            return SOFTSIM_POSES_NOTE;
        }
        if (is_left_out(poses, &out->pose, probe)) {
            continue;
        }
        const bool is_odd = advance_time(poses, event.utime_us);
        out->channel_probe = probe;
        out->time_us = poses->time_us;
        if (is_odd) {
            poses->pending = *out;
            poses->has_pending = true;
            snprintf(note, note_size,
                     "the log's clock jumps at byte %" PRId64 ", the jump is left out",
                     event.offset);
            return SOFTSIM_POSES_NOTE;
        }
        return SOFTSIM_POSES_POSE;
    }
}

softsim_poses_result softsim_poses_next(softsim_poses *poses, softsim_pose_event *out_event,
                                        char *note, size_t note_size)
{
    return poses->path != NULL ? next_of_path(poses, out_event, note, note_size)
                               : next_of_log(poses, out_event, note, note_size);
}

bool softsim_poses_is_damaged(const softsim_poses *poses)
{
    return poses->is_damaged;
}

bool softsim_poses_is_mixed(const softsim_poses *poses)
{
    return poses->mixed_offset >= 0;
}

void softsim_poses_restamp(softsim_pose *pose, int64_t sender, int32_t seq)
{
    pose->sender = sender;
    pose->seq = seq;
    pose->force_seq = -1;
    pose->flags = 0;
    ss_set3(pose->applied_force, NAN, NAN, NAN);
}
