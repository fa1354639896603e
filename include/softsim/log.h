/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Probe poses from files, and LCM event logs (what lcm-logger writes), without LCM itself.
 *
 * A log is read in bounded memory and is hostile: every length is checked before it is used, a
 * damaged record is named and the reader goes on at the next good one. A pose CSV has the header
 * `time_s,probe,x,y,z,qw,qx,qy,qz,buttons`, SI units, world frame, times that grow per probe.
 * Both give the same thing: a sequence of poses with their channel and their time.
 *
 * LCM's own lcm_eventlog_read_next_event is not used: it takes lengths from the file as they are
 * (a length of 0x7fffffff crashes it, 0x7ffffffe loses the rest of the log), and tells neither
 * damage nor a cut tail from the end.
 * Units: SI and the world frame as in softsim/types.h; times ending in _us are microseconds, in _s
 * seconds.
 * Errors: `error` is never NULL here; faults are added to it, with the file and the line or byte.
 * What opens or creates gives SOFTSIM_ERROR_FILE for what cannot be read or written, _FORMAT for a
 * CSV that is not one, or _MEMORY, and a NULL object.
 * Thread: an object belongs to one thread at a time; files are read as they are asked for, so no
 * call here is for a loop in real time but softsim_log_probe, _log_decode_*, _path_sample and
 * _poses_restamp, which neither allocate nor wait.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "softsim/types.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* ---- event logs: reading ---- */

/* LCM's limit of a channel name, and its NUL. */
#define SOFTSIM_LOG_CHANNEL_SIZE 64

/* Larger payloads are passed over unread (`data` NULL): our own messages are at most 65,000 B. */
#define SOFTSIM_LOG_MAX_DATA (128 * 1024)

typedef enum softsim_log_result {
    SOFTSIM_LOG_END,
    SOFTSIM_LOG_EVENT,
    SOFTSIM_LOG_DAMAGED,   /* `skipped` bytes from `offset` are no record; the next call goes on */
    SOFTSIM_LOG_TRUNCATED, /* the last record is cut: `skipped` bytes from `offset` */
    SOFTSIM_LOG_UNREADABLE /* the file system failed */
} softsim_log_result;

typedef struct softsim_log_event {
    int64_t offset;  /* byte of the file where the record, or the damage, starts */
    int64_t skipped; /* of damage: bytes */
    int64_t number;
    int64_t utime_us; /* the logger's clock at receipt */
    char channel[SOFTSIM_LOG_CHANNEL_SIZE];
    int32_t data_size;
    const uint8_t *data; /* valid until the next call; NULL: longer than SOFTSIM_LOG_MAX_DATA */
} softsim_log_event;

typedef struct softsim_log softsim_log;

/* Of any file: what is no log has damage from its first byte. */
softsim_status softsim_log_open(const char *path, softsim_log **out_log, softsim_error *error);
/* Accepts NULL; nulls. */
void softsim_log_close(softsim_log **log);
/* Back to the first record. */
void softsim_log_rewind(softsim_log *log);
/* The next record, or what is in its place. */
softsim_log_result softsim_log_next(softsim_log *log, softsim_log_event *out_event);

/* The probe number n of a channel `<any prefix>_PROBE_<n>`, -1 of any other. */
int32_t softsim_log_probe(const char *channel);
/* Decodes a probe_pose_t; false unless size and type hash are exactly right. Values are as they
 * came: not checked for being finite. */
bool softsim_log_decode_pose(const void *data, int32_t size, softsim_pose *out_pose);
/* The same of a contact_force_t. */
bool softsim_log_decode_force(const void *data, int32_t size, softsim_force *out_force);

/* ---- event logs: writing ---- */

typedef struct softsim_log_writer softsim_log_writer;

/* Writes to `path`.part, at least once a second and up to the end of a record, so that it can be
 * read whatever ends the program; the log appears at `path` when it is complete. A `path`.part that
 * a killed program left is renamed to `path`.1.part, or the next free number. */
softsim_status softsim_log_create(const char *path, softsim_log_writer **out_writer,
                                  softsim_error *error);
/* The same under a name that no user gave: nothing that is there is replaced. SOFTSIM_OK with a
 * NULL writer: the name, or its .part, is taken. A file that comes to `path` meanwhile stays, and
 * softsim_log_finish tells where the log is. */
softsim_status softsim_log_create_new(const char *path, softsim_log_writer **out_writer,
                                      softsim_error *error);
/* The file that is written to until softsim_log_finish. */
const char *softsim_log_path(const softsim_log_writer *writer);
/* What a `path`.part of a killed program was renamed to; NULL: there was none. Valid until the
 * writer is finished, kept or abandoned. */
const char *softsim_log_kept(const softsim_log_writer *writer);
/* Append one record. A fault is kept and reported by softsim_log_finish; records after it are
 * dropped. */
void softsim_log_write(softsim_log_writer *writer, int64_t utime_us, const char *channel,
                       const void *data, int32_t size);
void softsim_log_write_pose(softsim_log_writer *writer, int64_t utime_us, const char *channel,
                            const softsim_pose *pose);
void softsim_log_write_force(softsim_log_writer *writer, int64_t utime_us, const char *channel,
                             const softsim_force *force);
/* Has a record been lost? */
bool softsim_log_has_failed(const softsim_log_writer *writer);
/* Writes out, syncs, renames, frees and nulls; on a fault the records before it stay where
 * softsim_log_path says, which the error names. */
softsim_status softsim_log_finish(softsim_log_writer **writer, softsim_error *error);
/* A log that ends before its time: writes out, keeps it where softsim_log_path says, which the
 * error names, frees and nulls; accepts NULL. */
void softsim_log_keep(softsim_log_writer **writer, softsim_error *error);
/* Removes the temporary file, frees and nulls; accepts NULL. */
void softsim_log_abandon(softsim_log_writer **writer);

/* ---- pose paths ---- */

typedef struct softsim_path softsim_path;

/* Reads a pose CSV whole; every fault is named with its line. Half a row at the end of what a
 * bridge wrote is none: a kill may leave it, and it is left out. */
softsim_status softsim_path_load(const char *path, softsim_path **out_path, softsim_error *error);
/* Accepts NULL; nulls. */
void softsim_path_free(softsim_path **path);
/* Was one left out so? `note` says which line, without \n. */
bool softsim_path_note(const softsim_path *path, char *note, size_t note_size);
/* Bit n: probe n has rows. */
uint8_t softsim_path_probes(const softsim_path *path);
/* First and last time of the rows of `probe`; -1: of all probes together. A probe without rows
 * gives an empty range, begin after end. */
void softsim_path_range(const softsim_path *path, int32_t probe, double *out_begin_s,
                        double *out_end_s);
/* The pose of `probe` at `time_s`: position linear, orientation along the shortest arc, buttons of
 * the row before; velocity unknown. False outside the probe's own rows. Sets everything but
 * utime, sender, receive time and seq. */
bool softsim_path_sample(const softsim_path *path, int32_t probe, double time_s,
                         softsim_pose *out_pose);

/* ---- poses of either ---- */

typedef enum softsim_poses_result {
    SOFTSIM_POSES_END,
    SOFTSIM_POSES_POSE,
    SOFTSIM_POSES_NOTE /* something was skipped: the text says what; the next call goes on */
} softsim_poses_result;

typedef struct softsim_pose_event {
    softsim_pose pose;     /* as in the file; of a CSV: seq, sender, utime 0 */
    int32_t channel_probe; /* number of the channel; differs from pose.probe in bad logs */
    int64_t time_us;       /* from the first pose on, never decreasing */
} softsim_pose_event;

typedef struct softsim_poses softsim_poses;

/* Opens an event log or a pose CSV, told apart by content. A CSV is sampled on the times
 * k / rate_hz that it covers, probes in order at each.
 * A log may hold what other senders said on the same probe. Poses that its forces show to be
 * refused (those that answer their sender there have SOFTSIM_FORCE_OTHER_SENDER) and poses numbered
 * 0, which ask for a probe, are left out; a note at the end counts them. */
softsim_status softsim_poses_open(const char *path, double rate_hz, softsim_poses **out_poses,
                                  softsim_error *error);
/* Accepts NULL; nulls. */
void softsim_poses_close(softsim_poses **poses);
/* Back to the first pose. */
void softsim_poses_rewind(softsim_poses *poses);
/* Was anything skipped so far but a last record that is cut, as a kill of who recorded it leaves
 * it? Records are missing then; jumps of the log's clock and other senders' messages are none. */
bool softsim_poses_is_damaged(const softsim_poses *poses);
/* Has a log poses of two senders on one probe within half a second of each other, and no forces
 * that tell whose were taken? They are all there then: of two hands. Known from the start; a note
 * at the end says where. One sender after the other, as of a device that was started again, is
 * none. */
bool softsim_poses_is_mixed(const softsim_poses *poses);
/* `note` is filled for SOFTSIM_POSES_NOTE, one line without \n. */
softsim_poses_result softsim_poses_next(softsim_poses *poses, softsim_pose_event *out_event,
                                        char *note, size_t note_size);
/* Makes a recorded pose one of a new sender, as every player of logs does: sender and seq given,
 * force_seq -1, applied_force unknown, flags 0; the rest stays. */
void softsim_poses_restamp(softsim_pose *pose, int64_t sender, int32_t seq);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
