/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A stand-in for the server: a thread that answers each pose with a linear tissue at z = 0, and
 * that can lose messages, send rubbish, fall silent; and the files that clients write. Shared by
 * the tests of the client programs. cmocka comes first.
 */
#include <lcm/lcm.h>
#include <math.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/folder_fixture.h"
#include "common/log_fixture.h"
#include "net/codec.h"
#include "net/view_wire.h"
#include "process/process.h"
#include "rt/vec.h"
#include "softsim/log.h"
#include "softsim/status.h"
#include "softsim_server_status_t.h"

static const double stiffness = 400.0;
static process child;

/* ---- the stand-in ---- */

enum {
    MAX_KEPT = 20000,
    LATE_LOOKS = 40 /* of 20 ms: longer than a client usually waits for a last answer */
};

typedef struct server {
    /* parameters */
    int lose_pose_every;   /* 0: never; only the first arrival of a pose is lost */
    int lose_answer_every; /* 0: never; only the first answer to a pose is lost */
    bool sends_rubbish;
    bool is_mute;
    int mute_probe, mute_probe_from; /* its poses are not answered from number .. on; 0: none */
    int mute_from, mute_until; /* fresh poses that are not answered: number from .. until - 1 */
    int other_until;           /* earlier ones are answered as those of another sender */
    int other_from;            /* and from this one on; 0: never */
    int held_questions;        /* so many of whose a probe is find that another sender holds it */
    int replaced_from;         /* another server answers from this one on; 0: never */
    int raced_until;           /* a stranger answers earlier ones first, from where `next` speaks */
    int beside_at;             /* another server answers this one too; 0: none does */
    bool sends_scenes_beside;  /* from where `next` speaks, one a pose */
    bool is_late;              /* what is muted is answered once the poses have ended */
    int fault_from,
        fault_until; /* answers as one whose model is at fault: number from .. until - 1 */
    int pause_from, pause_until; /* as one that is paused */
    bool tells_state;            /* sends a status of either in time, */
    bool is_state_foreign;       /* as another than who sends the forces */
    bool is_entering;            /* answers as to a tool that has come up inside the tissue */
    bool sends_status;
    int counts_until; /* each command is answered by a lockstep server's count of poses,
                         up to this fresh one */

    /* state */
    lcm_t *lcm, *next; /* that replaces the first */
    pthread_t thread;
    atomic_bool is_stopping;
    atomic_int asked; /* commands since the last pose */
    atomic_int poses; /* that came, repeats included, questions not */
    int questions;
    int fresh, force_seq;
    int32_t last_seq[SOFTSIM_MAX_PROBES];
    softsim_pose kept[MAX_KEPT]; /* the fresh ones */
    softsim_force muted;         /* the last one */
    int idle;                    /* looks without a pose, one after the other */
} server;

static server stand_in;

static inline void publish_force_from(lcm_t *lcm, const char *channel, const softsim_force *force)
{
    uint8_t data[SS_WIRE_FORCE_SIZE];
    ss_wire_encode_force(force, data);
    lcm_publish(lcm, channel, data, sizeof data);
}

static inline void publish_force(server *s, const char *channel, const softsim_force *force)
{
    const bool is_replaced = s->replaced_from > 0 && s->fresh >= s->replaced_from;
    publish_force_from(is_replaced ? s->next : s->lcm, channel, force);
}

static inline void publish_rubbish(server *s, const char *channel, const softsim_force *force)
{
    uint8_t data[SS_WIRE_FORCE_SIZE + 8] = {0};
    softsim_force other = *force;
    lcm_publish(s->lcm, channel, data, sizeof data);
    lcm_publish(s->lcm, channel, data, 3);
    lcm_publish(s->lcm, channel, data, SS_WIRE_FORCE_SIZE); /* wrong type hash */
    other.sender ^= 1;
    other.force[0] = 1e6;
    publish_force(s, channel, &other);
    other = *force;
    other.force[1] = NAN;
    publish_force(s, channel, &other);
    other = *force;
    other.probe = 1 - other.probe;
    publish_force(s, channel, &other);
}

static inline bool is_at_fault(const server *s)
{
    return s->fault_from > 0 && s->fresh >= s->fault_from && s->fresh < s->fault_until;
}

static inline bool is_paused(const server *s)
{
    return s->pause_from > 0 && s->fresh >= s->pause_from && s->fresh < s->pause_until;
}

/* Whole, of a server that is at fault or paused, or neither. */
static inline void publish_state(server *s)
{
    static char scene[] = "stand-in.yaml";
    static char model[] = "linear";
    static char fault[] = "a number is not finite";
    static char none[] = "";
    const softsim_server_status_t status = {.seq = s->fresh,
                                            .scene = scene,
                                            .model = model,
                                            .reason = is_at_fault(s) ? fault : none,
                                            .verdict = is_at_fault(s) ? SOFTSIM_VERDICT_FAULT
                                                                      : SOFTSIM_VERDICT_GOOD,
                                            .fault_bits = is_paused(s) ? SOFTSIM_STATUS_PAUSED : 0};
    uint8_t data[2048];
    const int size = softsim_server_status_t_encode(data, 0, sizeof data, &status);
    lcm_publish(s->is_state_foreign ? s->next : s->lcm, "SOFTSIM_STATUS", data, (unsigned)size);
}

static inline void publish_status(server *s)
{
    static char scene[] = "stand-in.yaml";
    static char model[] = "linear";
    static char reason[] = "";
    const softsim_server_status_t status = {
        .seq = s->fresh, .scene = scene, .model = model, .reason = reason, .uptime_s = 2.5};
    uint8_t data[2048];
    const int size = softsim_server_status_t_encode(data, 0, sizeof data, &status);
    uint8_t bad[2048];
    /* Each string length damaged in turn, then a cut message: none may be believed. */
    static const int string_at[3] = {0, 4 + sizeof scene, 8 + sizeof scene + sizeof model};
    const int strings = size - (int)(12 + sizeof scene + sizeof model + sizeof reason);
    static const uint32_t lengths[] = {0, 0x7FFFFFFF, 0xFFFFFFFF, 0x40000001, 5};
    for (int i = 0; i < 3; ++i) {
        for (size_t k = 0; k < sizeof lengths / sizeof lengths[0]; ++k) {
            memcpy(bad, data, (size_t)size);
            for (int b = 0; b < 4; ++b) {
                bad[strings + string_at[i] + b] = (uint8_t)(lengths[k] >> (24 - 8 * b));
            }
            lcm_publish(s->lcm, "SOFTSIM_STATUS", bad, (unsigned)size);
        }
    }
    lcm_publish(s->lcm, "SOFTSIM_STATUS", data, (unsigned)size - 1);
    lcm_publish(s->lcm, "SOFTSIM_STATUS", data, (unsigned)size);
}

/* As a viewer on the same host might send again what it has heard. */
static inline void publish_scene(lcm_t *lcm)
{
    const softsim_scene_report scene = {
        .name = "stand-in.yaml", .model = "linear", .field = "none"};
    uint8_t data[4096];
    const int size = ss_view_encode_scene(&scene, data, sizeof data);
    assert_true(size > 0);
    lcm_publish(lcm, "SOFTSIM_SCENE", data, (unsigned)size);
}

static inline bool is_mute_to(const server *s, int32_t probe)
{
    return s->is_mute ||
           (s->mute_probe > 0 && probe == s->mute_probe && s->fresh >= s->mute_probe_from);
}

/* A replay's before its log begins: a pose with the number 0. */
static inline void answer_question(server *s, const softsim_pose *pose, int32_t probe)
{
    const softsim_force force = {
        .sender = pose->sender,
        .pose_utime_us = pose->utime_us,
        .probe = probe,
        .flags = ++s->questions <= s->held_questions ? SOFTSIM_FORCE_OTHER_SENDER : 0};
    char answer[64];
    snprintf(answer, sizeof answer, "SOFTSIM_FORCE_%d", probe);
    if (!is_mute_to(s, probe)) {
        publish_force(s, answer, &force);
    }
}

static inline void on_pose(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    server *s = context;
    softsim_pose pose;
    const int32_t probe = softsim_log_probe(channel);
    if (!softsim_log_decode_pose(buffer->data, (int32_t)buffer->data_size, &pose)) {
        return;
    }
    if (pose.seq == 0) {
        answer_question(s, &pose, probe);
        return;
    }
    ++s->poses;
    s->asked = 0;
    const bool is_fresh = pose.seq != s->last_seq[probe];
    s->last_seq[probe] = pose.seq;
    if (is_fresh) {
        s->kept[s->fresh++ % MAX_KEPT] = pose;
        if (s->lose_pose_every > 0 && s->fresh % s->lose_pose_every == 0) {
            s->last_seq[probe] = 0;
            --s->fresh;
            s->lose_pose_every += 1000; /* it comes again */
            return;
        }
    }
    softsim_force force = {.utime_us = pose.utime_us,
                           .sender = pose.sender,
                           .pose_utime_us = pose.utime_us,
                           .seq = ++s->force_seq,
                           .probe = probe,
                           .pose_seq = pose.seq,
                           .flags = pose.position[2] < 0.0 ? SOFTSIM_FORCE_CONTACT : 0,
                           .normal = {0.0, 0.0, 1.0},
                           .stiffness = pose.position[2] < 0.0 ? stiffness : 0.0};
    force.force[2] = fmax(0.0, -stiffness * pose.position[2]);
    force.depth = fmax(0.0, -pose.position[2]);
    if (s->is_entering && s->fresh < 500) {
        force.flags |= SOFTSIM_FORCE_RAMPING;
        force.depth = 0.01;
    }
    if (s->fresh < s->other_until || (s->other_from > 0 && s->fresh >= s->other_from)) {
        force = (softsim_force){.sender = pose.sender,
                                .probe = probe,
                                .pose_seq = pose.seq,
                                .flags = SOFTSIM_FORCE_OTHER_SENDER};
    }
    if (is_at_fault(s) || is_paused(s)) {
        ss_set3(force.force, 0.0, 0.0, 0.0);
        force.depth = force.stiffness = 0.0;
        force.flags = SOFTSIM_FORCE_RAMPING | (is_at_fault(s) ? SOFTSIM_FORCE_MODEL_FAULT : 0);
    }
    if (s->tells_state && is_fresh && s->fresh % 50 == 0) {
        publish_state(s);
    }
    char answer[64];
    snprintf(answer, sizeof answer, "SOFTSIM_FORCE_%d", probe);
    if (s->fresh < s->raced_until) {
        softsim_force forged = force;
        forged.flags = SOFTSIM_FORCE_CONTACT;
        ss_set3(forged.force, 0.0, 0.0, 1e4);
        publish_force_from(s->next, answer, &forged);
    }
    if (s->sends_rubbish) {
        publish_rubbish(s, answer, &force);
    }
    if (s->sends_status) {
        publish_status(s);
    }
    const bool is_lost =
        is_fresh && s->lose_answer_every > 0 && s->fresh % s->lose_answer_every == 0;
    const bool is_mute =
        is_mute_to(s, probe) || (s->fresh >= s->mute_from && s->fresh < s->mute_until);
    if (!is_mute && !is_lost) {
        publish_force(s, answer, &force);
    } else {
        s->muted = force;
    }
    if (s->fresh == s->beside_at) {
        publish_force_from(s->next, answer, &force);
    }
    if (s->sends_scenes_beside && s->fresh > 5) { /* once it is known who answers */
        publish_scene(s->next);
    }
}

static inline void on_command(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    server *s = context;
    static char none[] = "";
    (void)buffer, (void)channel;
    ++s->asked;
    if (s->fresh <= s->counts_until && s->counts_until > 0) {
        const softsim_server_status_t status = {.utime = (int64_t)(1e6 * process_now_s()),
                                                .scene = none,
                                                .model = none,
                                                .reason = none,
                                                .state_hash = 5,
                                                .poses_received = s->fresh};
        softsim_server_status_t_publish(s->lcm, "SOFTSIM_STATUS", &status);
    }
}

static inline void *serve(void *argument)
{
    server *s = argument;
    while (!s->is_stopping) {
        struct pollfd ready = {.fd = lcm_get_fileno(s->lcm), .events = POLLIN};
        if (poll(&ready, 1, 20) > 0) {
            lcm_handle(s->lcm);
            s->idle = 0;
        } else if (s->is_late && s->muted.pose_seq > 0 && ++s->idle == LATE_LOOKS) {
            publish_force(s, "SOFTSIM_FORCE_0", &s->muted);
        } else if (s->sends_status) {
            publish_status(s);
        } else if (s->tells_state) {
            publish_state(s);
        }
    }
    return NULL;
}

/* Set the parameters in stand_in first. */
static inline void start_server(void)
{
    stand_in.lcm = lcm_create(NULL);
    stand_in.next = lcm_create(NULL);
    assert_true(stand_in.lcm != NULL && stand_in.next != NULL);
    lcm_subscription_t *all =
        lcm_subscribe(stand_in.lcm, "SOFTSIM_PROBE_[0-7]", on_pose, &stand_in);
    assert_non_null(all);
    lcm_subscription_set_queue_capacity(all, 10000);
    assert_non_null(lcm_subscribe(stand_in.lcm, "SOFTSIM_COMMAND", on_command, &stand_in));
    assert_int_equal(pthread_create(&stand_in.thread, NULL, serve, &stand_in), 0);
}

/* Messages that found no room in a socket of this network, so far: what is lost without being
 * counted here is an error of ours. */
static inline long count_dropped(void)
{
    FILE *file = fopen("/proc/net/snmp", "r");
    assert_non_null(file);
    char line[1024];
    long dropped = -1;
    while (fgets(line, sizeof line, file) != NULL) {
        if (sscanf(line, "Udp: %*d %*d %*d %*d %ld", &dropped) == 1) {
            break;
        }
    }
    fclose(file);
    assert_true(dropped >= 0);
    return dropped;
}

/* All that was sent has come, but for what is counted as dropped. */
static inline void await_poses(int sent, long dropped_before)
{
    const double begin_s = process_now_s();
    while (stand_in.poses + count_dropped() - dropped_before < sent) {
        if (process_now_s() - begin_s > HANG_S) {
            fail_msg("%d of %d poses came, %ld messages were dropped", stand_in.poses, sent,
                     count_dropped() - dropped_before);
        }
        poll(NULL, 0, 5);
    }
}

static inline void stop_server(void)
{
    stand_in.is_stopping = true;
    pthread_join(stand_in.thread, NULL);
    lcm_destroy(stand_in.lcm);
    lcm_destroy(stand_in.next);
    stand_in.lcm = stand_in.next = NULL;
}

/* ---- files ---- */

static inline int set_up(void **state)
{
    memset(&stand_in, 0, sizeof stand_in);
    return make_folder(state);
}

static inline int tear_down(void **state)
{
    if (stand_in.lcm != NULL) {
        stop_server();
    }
    process_signal(&child, SIGKILL);
    process_finish(&child);
    return remove_folder(state);
}

/* A log at 1 kHz, `count` ticks of `probes` probes, each going down to -5 mm and up again. */
static inline void make_log(const char *path, int count, int probes)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    assert_int_equal(softsim_log_create(path, &writer, &error), SOFTSIM_OK);
    for (int i = 0; i < count; ++i) {
        for (int p = 0; p < probes; ++p) {
            char channel[32];
            softsim_pose pose = {.utime_us = 5000000 + 1000 * i,
                                 .sender = 123,
                                 .seq = 1000 + i,
                                 .probe = p,
                                 .force_seq = 9,
                                 .flags = 1,
                                 .orientation = {1.0, 0.0, 0.0, 0.0},
                                 .velocity = {0.125, 0.0, 0.0}};
            pose.position[2] = 0.005 * cos(2.0 * SS_PI * i / count);
            snprintf(channel, sizeof channel, "OLD_PROBE_%d", p);
            softsim_log_write_pose(writer, 70000000 + 1000 * i, channel, &pose);
        }
    }
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
}

typedef struct csv_row {
    int pose_seq, probe, flags;
    long long latency_us;
    double force[3], depth, stiffness;
} csv_row;
static csv_row rows[MAX_KEPT];

static inline int read_csv(const char *path)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    char line[1024];
    int count = 0;
    assert_non_null(fgets(line, sizeof line, file));
    assert_string_equal(line, "pose_seq,pose_utime,probe,fx,fy,fz,tx,ty,tz,depth_m,"
                              "stiffness_n_per_m,model_age_us,flags,latency_us,indentation_m\n");
    while (count < MAX_KEPT && fgets(line, sizeof line, file) != NULL) {
        csv_row *r = &rows[count++];
        assert_int_equal(sscanf(line, "%d,%*d,%d,%lf,%lf,%lf,%*f,%*f,%*f,%lf,%lf,%*d,%d,%lld",
                                &r->pose_seq, &r->probe, &r->force[0], &r->force[1], &r->force[2],
                                &r->depth, &r->stiffness, &r->flags, &r->latency_us),
                         9);
    }
    fclose(file);
    return count;
}

static inline void expect_status(int expected)
{
    const int status = process_finish(&child);
    if (status != expected) {
        fail_msg("status %d, not %d: %s%s", status, expected, child.out, child.err);
    }
}

/* The program from its start to its end, with a server there. */
static inline void run_served(const char *const *argv, int status)
{
    start_server();
    process_start(&child, argv, NULL);
    expect_status(status);
    stop_server();
}

/* The same among rubbish, until the server has all that was sent. How many were dropped before. */
static inline long run_among_rubbish(const char *const *argv, int poses)
{
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.sends_rubbish = true;
    const long dropped_before = count_dropped();
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    await_poses(poses, dropped_before);
    stop_server();
    return dropped_before;
}

/* And stopped by `signal` after a hundred poses. */
static inline void run_until_stopped(const char *const *argv, int signal, int status)
{
    start_server();
    process_start(&child, argv, NULL);
    while (stand_in.poses < 100 && !process_has_ended(&child)) {
        poll(NULL, 0, 5);
    }
    process_signal(&child, signal);
    expect_status(status);
    stop_server();
}

/* Stops the child after a hundred poses, for a second and a half of the clock or more. */
static inline void suspend_child(void)
{
    while (stand_in.poses < 100 && !process_has_ended(&child)) {
        poll(NULL, 0, 5);
    }
    process_signal(&child, SIGSTOP);
    const double begin_s = process_now_s();
    while (process_now_s() - begin_s < 1.5) {
        poll(NULL, 0, 100);
    }
    process_signal(&child, SIGCONT);
}

/* The child is stopped for longer than a second, with some of its run left. Where it had less left,
 * since the machine held this test back, it is run again. What it says of that, from there on. */
static inline const char *run_suspended(const char *const *argv)
{
    const char *said = NULL;
    for (int runs = 0; said == NULL; ++runs) {
        assert_true(runs < 20);
        memset(&stand_in, 0, sizeof stand_in);
        start_server();
        process_start(&child, argv, NULL);
        suspend_child();
        const int status = process_finish(&child);
        stop_server();
        said = strstr(child.err, "this program was held up for ");
        assert_true(said == NULL || status == 1);
    }
    assert_null(strstr(said + 1, "this program was"));
    return said;
}

/* Until a recording has something in it; it is flushed once a second. */
static inline void wait_for_file(const char *path)
{
    struct stat found;
    const double begin_s = process_now_s();
    while ((stat(path, &found) != 0 || found.st_size == 0) && !process_has_ended(&child) &&
           process_now_s() - begin_s < HANG_S) {
        poll(NULL, 0, 5);
    }
    assert_int_equal(stat(path, &found), 0);
    assert_true(found.st_size > 0);
}

/* Lines of a CSV, each whole and with as many columns as its first. A killed writer may leave half
 * a line at the end, which is none. */
static inline int count_lines(const char *path, bool is_killed)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    char line[2048];
    int count = 0, columns = 0;
    for (; fgets(line, sizeof line, file) != NULL; ++count) {
        if (is_killed && strchr(line, '\n') == NULL) {
            break;
        }
        int commas = 0;
        for (const char *at = line; (at = strchr(at, ',')) != NULL; ++at) {
            ++commas;
        }
        columns = count == 0 ? commas : columns;
        assert_int_equal(commas, columns);
        assert_non_null(strchr(line, '\n'));
    }
    fclose(file);
    return count;
}

/* A case with a server and a folder of its own. */
#define SERVED_TEST(name) TEST_WITH(name, set_up, tear_down)
