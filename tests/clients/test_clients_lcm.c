/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The client programs against a stand-in for the server: a thread that answers each pose with a
 * linear tissue at z = 0, and that can lose messages, send rubbish, fall silent.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
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
#include <sys/wait.h>
#include <unistd.h>

#include "common/folder_fixture.h"
#include "process/process.h"
#include "softsim/log.h"
#include "softsim_server_status_t.h"
#include "wire.h"

static const double stiffness = 400.0;
static process child;
static process patient, asking; /* wait all the while for a server that never comes */

/* ---- the stand-in ---- */

enum { MAX_KEPT = 20000 };

typedef struct server {
    /* parameters */
    int lose_pose_every;   /* 0: never; only the first arrival of a pose is lost */
    int lose_answer_every; /* 0: never; only the first answer to a pose is lost */
    bool sends_rubbish;
    bool is_mute;
    int mute_from, mute_until; /* fresh poses that are not answered: number from .. until - 1 */
    int other_until;           /* earlier ones are answered as those of another sender */
    bool is_entering;          /* answers as to a tool that has come up inside the tissue */
    bool sends_status;

    /* state */
    lcm_t *lcm;
    pthread_t thread;
    atomic_bool is_stopping;
    atomic_int poses; /* that came, repeats included */
    int fresh, force_seq;
    int32_t last_seq[SOFTSIM_MAX_PROBES];
    softsim_pose kept[MAX_KEPT]; /* the fresh ones */
} server;

static server stand_in;

static void publish_force(server *s, const char *channel, const softsim_force *force)
{
    uint8_t data[SS_WIRE_FORCE_SIZE];
    ss_wire_encode_force(force, data);
    lcm_publish(s->lcm, channel, data, sizeof data);
}

static void publish_rubbish(server *s, const char *channel, const softsim_force *force)
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

static void publish_status(server *s)
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

static void on_pose(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    server *s = context;
    softsim_pose pose;
    const int32_t probe = softsim_log_probe(channel);
    if (!softsim_log_decode_pose(buffer->data, (int32_t)buffer->data_size, &pose)) {
        return;
    }
    ++s->poses;
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
    if (s->fresh < s->other_until) {
        force = (softsim_force){.sender = pose.sender,
                                .probe = probe,
                                .pose_seq = pose.seq,
                                .flags = SOFTSIM_FORCE_OTHER_SENDER};
    }
    char answer[64];
    snprintf(answer, sizeof answer, "SOFTSIM_FORCE_%d", probe);
    if (s->sends_rubbish) {
        publish_rubbish(s, answer, &force);
    }
    if (s->sends_status) {
        publish_status(s);
    }
    const bool is_lost =
        is_fresh && s->lose_answer_every > 0 && s->fresh % s->lose_answer_every == 0;
    const bool is_mute = s->is_mute || (s->fresh >= s->mute_from && s->fresh < s->mute_until);
    if (!is_mute && !is_lost) {
        publish_force(s, answer, &force);
    }
}

static void *serve(void *argument)
{
    server *s = argument;
    while (!s->is_stopping) {
        struct pollfd ready = {.fd = lcm_get_fileno(s->lcm), .events = POLLIN};
        if (poll(&ready, 1, 20) > 0) {
            lcm_handle(s->lcm);
        } else if (s->sends_status) {
            publish_status(s);
        }
    }
    return NULL;
}

/* Set the parameters in stand_in first. */
static void start_server(void)
{
    stand_in.lcm = lcm_create(NULL);
    assert_non_null(stand_in.lcm);
    lcm_subscription_t *all =
        lcm_subscribe(stand_in.lcm, "SOFTSIM_PROBE_[0-7]", on_pose, &stand_in);
    assert_non_null(all);
    lcm_subscription_set_queue_capacity(all, 10000);
    assert_int_equal(pthread_create(&stand_in.thread, NULL, serve, &stand_in), 0);
}

/* Messages that found no room in a socket of this network, so far: what is lost without being
 * counted here is an error of ours. */
static long count_dropped(void)
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
static void await_poses(int sent, long dropped_before)
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

static void stop_server(void)
{
    stand_in.is_stopping = true;
    pthread_join(stand_in.thread, NULL);
    lcm_destroy(stand_in.lcm);
    stand_in.lcm = NULL;
}

/* ---- files ---- */

static int set_up(void **state)
{
    memset(&stand_in, 0, sizeof stand_in);
    return make_folder(state);
}

static int tear_down(void **state)
{
    if (stand_in.lcm != NULL) {
        stop_server();
    }
    process_signal(&child, SIGKILL);
    process_finish(&child);
    return remove_folder(state);
}

/* A log at 1 kHz, `count` ticks of `probes` probes, each going down to -5 mm and up again. */
static void make_log(const char *path, int count, int probes)
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
            pose.position[2] = 0.005 * cos(6.283185307179586 * i / count);
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

static int read_csv(const char *path)
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

static void expect_status(int expected)
{
    const int status = process_finish(&child);
    if (status != expected) {
        fail_msg("status %d, not %d: %s%s", status, expected, child.out, child.err);
    }
}

/* ---- replay ---- */

static void lockstep_answers_every_pose_once(void **state)
{
    (void)state;
    const char *log = in_folder("a.lcmlog");
    const char *csv = in_folder("a.csv");
    const char *record = in_folder("r.lcmlog");
    const char *const argv[] = {"softsim-replay", log,    "--lockstep", "--csv", csv,
                                "--record",       record, "--repeat",   "2",     NULL};
    make_log(log, 150, 2);
    stand_in.lose_pose_every = 101;
    stand_in.lose_answer_every = 200;
    stand_in.sends_rubbish = true;
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    stop_server();
    assert_int_equal(read_csv(csv), 600);
    assert_int_equal(stand_in.fresh, 600);
    for (int i = 0; i < 600; ++i) {
        const softsim_pose *pose = &stand_in.kept[i];
        assert_int_equal(rows[i].pose_seq, i + 1);
        assert_int_equal(rows[i].probe, i % 2);
        assert_true(rows[i].force[2] == fmax(0.0, -stiffness * pose->position[2]));
        assert_true(rows[i].depth == fmax(0.0, -pose->position[2]));
        assert_true(rows[i].force[0] == 0.0 && rows[i].latency_us >= 0);
        /* a sender of its own, everything that belonged to the old one replaced */
        assert_true(pose->sender == stand_in.kept[0].sender && pose->sender != 123);
        assert_true(pose->seq == i + 1 && pose->force_seq == -1 && pose->flags == 0);
        assert_true(isnan(pose->applied_force[0]) && pose->velocity[0] == 0.125);
        assert_true(i == 0 || pose->utime_us >= stand_in.kept[i - 1].utime_us);
        assert_true(pose->utime_us != 5000000 + 1000 * (i / 2));
    }
    assert_non_null(strstr(child.err, "2 probes"));
    assert_non_null(strstr(child.out, "600 sent, 600 answered, 0 missing"));
    /* What was recorded: every pose, and every force that was for us. */
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *recorded = NULL;
    softsim_log_event event;
    int poses = 0;
    int forces = 0;
    assert_int_equal(softsim_log_open(record, &recorded, &error), SOFTSIM_OK);
    while (softsim_log_next(recorded, &event) == SOFTSIM_LOG_EVENT) {
        softsim_pose pose;
        softsim_force force;
        poses += softsim_log_probe(event.channel) >= 0 &&
                 softsim_log_decode_pose(event.data, event.data_size, &pose);
        forces += strncmp(event.channel, "SOFTSIM_FORCE_", 14) == 0 &&
                  softsim_log_decode_force(event.data, event.data_size, &force) &&
                  force.sender == stand_in.kept[0].sender;
    }
    softsim_log_close(&recorded);
    assert_int_equal(poses, 600);
    assert_true(forces >= 600);
}

/* A machine that holds one of the two back for long loses messages on their way: so many as it
 * says, and no more. Only where the last pose is answered is none still on its way: else it is
 * played again. */
static void paced_replay_keeps_the_answers(void **state)
{
    (void)state;
    const char *log = in_folder("a.lcmlog");
    const char *csv = in_folder("a.csv");
    const char *const argv[] = {"softsim-replay", log, "--csv", csv, NULL};
    make_log(log, 400, 1);
    int count = 0, last = 0;
    for (int attempt = 0; attempt < 10 && last != 400; ++attempt) {
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.sends_rubbish = true;
        const long before = count_dropped();
        start_server();
        process_start(&child, argv, NULL);
        expect_status(0);
        await_poses(400, before);
        stop_server();
        count = read_csv(csv);
        assert_in_range(count, 1, stand_in.fresh);
        last = rows[count - 1].pose_seq;
        assert_true(last < 400 || 400 - count <= count_dropped() - before);
    }
    assert_int_equal(last, 400); /* else it has never waited for the rest */
    double peak = 0.0;
    for (int i = 0, k = 0; i < count; ++i, ++k) {
        while (k < stand_in.fresh && stand_in.kept[k].seq != rows[i].pose_seq) {
            ++k;
        }
        assert_true(k < stand_in.fresh);
        assert_true(rows[i].force[2] == fmax(0.0, -stiffness * stand_in.kept[k].position[2]));
        peak = fmax(peak, rows[i].force[2]);
    }
    char summary[2][64];
    snprintf(summary[0], sizeof summary[0], "400 sent, %d answered, %d missing", count,
             400 - count);
    snprintf(summary[1], sizeof summary[1], "peak %.6g N", peak);
    assert_non_null(strstr(child.out, summary[0]));
    assert_non_null(strstr(child.out, summary[1]));
}

static void pose_csv_is_replayed(void **state)
{
    (void)state;
    const char *path = in_folder("p.csv");
    const char *const argv[] = {"softsim-replay", path, "--lockstep", "--rate", "500", NULL};
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(
        "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,3,0,0,0,1,0,0,0,0\n0.1,3,0,0,-0.01,1,0,0,0,1\n",
        file);
    fclose(file);
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    stop_server();
    assert_int_equal(stand_in.fresh, 51);
    assert_int_equal(stand_in.kept[50].buttons, 1);
    assert_true(stand_in.kept[25].probe == 3 && isnan(stand_in.kept[25].velocity[0]));
    assert_true(fabs(stand_in.kept[25].position[2] + 0.005) < 1e-15);
}

static void silence_is_a_failure(void **state)
{
    (void)state;
    const char *log = in_folder("a.lcmlog");
    const char *const argv[] = {"softsim-replay", log, "--lockstep", NULL};
    make_log(log, 10, 1);
    stand_in.is_mute = true;
    start_server();
    process_start(&child, argv, NULL);
    expect_status(1);
    assert_non_null(strstr(child.err, "no answer for 5 s after pose 1"));
    stop_server();
    assert_in_range(stand_in.poses, 10, 60); /* the pose was sent again and again */
}

/* A file has its name once it is complete; what there is until then stays, and is named. */
static void stopped_replay_keeps_its_files(void **state)
{
    (void)state;
    const char *log = in_folder("a.lcmlog");
    const char *csv = in_folder("a.csv"), *csv_part = in_folder("a.csv.part");
    const char *record = in_folder("r.lcmlog"), *record_part = in_folder("r.lcmlog.part");
    const char *const argv[] = {"softsim-replay", log, "--csv", csv, "--record", record, NULL};
    make_log(log, 30000, 1);
    start_server();
    process_start(&child, argv, NULL);
    while (stand_in.poses < 100 && !process_has_ended(&child)) {
        poll(NULL, 0, 5);
    }
    process_signal(&child, SIGINT);
    expect_status(1);
    stop_server();
    const char *stopped = strstr(child.err, "stopped after");
    assert_non_null(stopped);
    assert_non_null(strstr(stopped, "a.csv: not complete; what was recorded is in "));
    assert_non_null(strstr(stopped, csv_part));
    assert_non_null(strstr(stopped, record_part));
    assert_true(read_csv(csv_part) > 0);
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *recorded = NULL;
    softsim_log_event event;
    softsim_log_result result;
    assert_int_equal(softsim_log_open(record_part, &recorded, &error), SOFTSIM_OK);
    while ((result = softsim_log_next(recorded, &event)) == SOFTSIM_LOG_EVENT) {
    }
    assert_int_equal(result, SOFTSIM_LOG_END);
    softsim_log_close(&recorded);
    assert_int_equal(access(csv, F_OK), -1);
    assert_int_equal(access(record, F_OK), -1);
}

/* ---- what a kill leaves ---- */

/* Until a recording has something in it; it is flushed once a second. */
static void wait_for_file(const char *path)
{
    struct stat found;
    for (int i = 0; i < 12000 && (stat(path, &found) != 0 || found.st_size == 0); ++i) {
        poll(NULL, 0, 5);
    }
    assert_int_equal(stat(path, &found), 0);
    assert_true(found.st_size > 0);
}

/* Lines of a CSV, its last one whole and with as many columns as its first. */
static int count_lines(const char *path)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    char line[2048];
    int count = 0, columns = 0;
    for (; fgets(line, sizeof line, file) != NULL; ++count) {
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

static void a_killed_replay_leaves_what_it_recorded(void **state)
{
    (void)state;
    const char *log = in_folder("a.lcmlog");
    const char *csv = in_folder("k.csv"), *csv_part = in_folder("k.csv.part");
    const char *record = in_folder("k.lcmlog"), *record_part = in_folder("k.lcmlog.part");
    const char *const argv[] = {"softsim-replay", log, "--csv", csv, "--record", record, NULL};
    make_log(log, 30000, 1);
    start_server();
    process_start(&child, argv, NULL);
    wait_for_file(csv_part);
    wait_for_file(record_part);
    process_signal(&child, SIGKILL);
    expect_status(128 + SIGKILL);
    stop_server();
    assert_non_null(strstr(child.err, csv_part)); /* told while it could */
    assert_non_null(strstr(child.err, record_part));
    assert_true(count_lines(csv_part) > 1);
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *recorded = NULL;
    softsim_log_event event;
    softsim_log_result result;
    int count = 0;
    assert_int_equal(softsim_log_open(record_part, &recorded, &error), SOFTSIM_OK);
    while ((result = softsim_log_next(recorded, &event)) == SOFTSIM_LOG_EVENT) {
        ++count;
    }
    assert_int_equal(result, SOFTSIM_LOG_END); /* nothing cut, nothing damaged */
    assert_true(count > 10);
    softsim_log_close(&recorded);
    assert_int_equal(access(csv, F_OK), -1);
    assert_int_equal(access(record, F_OK), -1);
    /* Nor may what was left be written over by who plays it. */
    const char *const over[] = {"softsim-replay", record_part, "--record", record, NULL};
    assert_int_equal(process_run(&child, over), 2);
    assert_non_null(strstr(child.err, "k.lcmlog.part', which is the file played"));
}

/* One that has an end of its own, with a server and without. */
static void a_stopped_bridge_keeps_its_file(void **state)
{
    (void)state;
    const char *csv = in_folder("s.csv"), *part = in_folder("s.csv.part");
    const char *const served[] = {"softsim-bridge", "--device", "sim", "--duration",
                                  "1000",           "--csv",    csv,   NULL};
    const char *const linear[] = {
        "softsim-bridge", "--device", "sim", "--linear-tissue", "500", "--ticks", "1e9",
        "--csv",          csv,        NULL};
    start_server();
    for (int i = 0; i < 2; ++i) {
        process_start(&child, i == 0 ? served : linear, NULL);
        wait_for_file(part);
        process_signal(&child, SIGTERM);
        expect_status(1);
        const char *ended = strstr(child.err, "ended before its time, after ");
        assert_non_null(ended);
        assert_non_null(strstr(ended, "s.csv: not complete; what was recorded is in "));
        assert_true(count_lines(part) > 10);
        assert_int_equal(access(csv, F_OK), -1);
        assert_int_equal(unlink(part), 0);
    }
    stop_server();
}

static void a_killed_bridge_leaves_what_it_recorded(void **state)
{
    (void)state;
    const char *csv = in_folder("b.csv"), *part = in_folder("b.csv.part");
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--csv", csv, NULL};
    start_server();
    process_start(&child, argv, NULL);
    wait_for_file(part);
    process_signal(&child, SIGKILL);
    expect_status(128 + SIGKILL);
    stop_server();
    assert_non_null(strstr(child.err, part));
    assert_int_equal(access(csv, F_OK), -1);
    const int lines = count_lines(part);
    assert_true(lines > 10);
    /* It can be played: as many poses as it has rows. */
    const char *again = in_folder("b.lcmlog");
    const char *const convert[] = {"softsim-replay", "--convert", part, again, NULL};
    assert_int_equal(process_run(&child, convert), 0);
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *converted = NULL;
    softsim_log_event event;
    int poses = 0, kept = 0;
    assert_int_equal(softsim_log_open(again, &converted, &error), SOFTSIM_OK);
    while (softsim_log_next(converted, &event) == SOFTSIM_LOG_EVENT) {
        softsim_pose pose;
        assert_true(softsim_log_decode_pose(event.data, event.data_size, &pose));
        const bool has_come = kept < stand_in.fresh && stand_in.kept[kept].seq == poses + 1;
        for (int i = 0; i < 3 && has_come; ++i) {
            assert_true(fabs(pose.position[i] - stand_in.kept[kept].position[i]) < 1e-12);
        }
        kept += has_come;
        ++poses;
    }
    assert_true(kept > 0);
    assert_int_equal(poses, lines - 1);
    softsim_log_close(&converted);
}

/* SIGHUP, as of a terminal that is closed, is an end like SIGTERM, and one that has no other is
 * complete: its file, a summary. */
static void a_hangup_ends_in_order(void **state)
{
    (void)state;
    const char *csv = in_folder("h.csv");
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--csv", csv, NULL};
    start_server();
    process_start(&child, argv, NULL);
    for (int i = 0; i < 12000 && stand_in.poses < 100; ++i) {
        poll(NULL, 0, 5);
    }
    process_signal(&child, SIGHUP);
    expect_status(0);
    stop_server();
    assert_non_null(strstr(child.out, "peak force"));
    assert_true(count_lines(csv) > 50);
}

/* With a closed stderr the CSV would be number 2 and take what is said there. */
static void closed_descriptors_write_into_no_file(void **state)
{
    (void)state;
    const char *csv = in_folder("c.csv");
    char command[512];
    snprintf(command, sizeof command,
             BIN_DIR "/softsim-bridge --device sim --ticks 50 --csv %s 2>&- >/dev/null", csv);
    const int status = system(command);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 1); /* no force came */
    assert_int_equal(count_lines(csv), 51);
}

/* What is felt at a probe is shown to who only watches. */
static void monitor_shows_force_and_indentation(void **state)
{
    (void)state;
    const char *const bridge[] = {"softsim-bridge", "--device", "sim", NULL};
    const char *const monitor[] = {"softsim-monitor", NULL};
    static process hand;
    stand_in.sends_status = true;
    start_server();
    process_start(&hand, bridge, NULL);
    process_start(&child, monitor, NULL);
    const bool is_shown = process_wait_for(&child, " N, pressed in ");
    process_signal(&hand, SIGTERM);
    process_finish(&hand);
    process_signal(&child, SIGTERM);
    process_finish(&child);
    stop_server();
    if (!is_shown) {
        fail_msg("%s%s", child.out, child.err);
    }
    assert_non_null(strstr(child.out, "2.5 s good: probe 0 "));
}

static void damaged_logs_are_played_and_named(void **state)
{
    (void)state;
    const char *log = in_folder("a.lcmlog");
    const char *const argv[] = {"softsim-replay", log, "--lockstep", NULL};
    make_log(log, 20, 1);
    FILE *file = fopen(log, "r+b");
    assert_non_null(file);
    const long record = 28 + 11 + SS_WIRE_POSE_SIZE;
    static const unsigned char huge[4] = {0x7F, 0xFF, 0xFF, 0xFF};
    fseek(file, 4 * record + 24, SEEK_SET);
    fwrite(huge, 1, 4, file);
    fclose(file);
    assert_int_equal(truncate(log, 20 * record - 7), 0);
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    stop_server();
    char expected[128];
    snprintf(expected, sizeof expected, "damaged record at byte %ld, skipped %ld bytes", 4 * record,
             record);
    assert_non_null(strstr(child.err, expected));
    snprintf(expected, sizeof expected, "truncated record at byte %ld", 19 * record);
    assert_non_null(strstr(child.err, expected));
    assert_int_equal(stand_in.fresh, 18);
}

static void conversion_is_reproducible(void **state)
{
    (void)state;
    const char *path = in_folder("p.csv");
    const char *first = in_folder("1.lcmlog");
    const char *second = in_folder("2.lcmlog");
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,0,0,0,1,0,0,0,0\n1,0,1,0,0,1,0,0,0,0\n",
          file);
    fclose(file);
    const char *const once[] = {"softsim-replay", "--convert", path, first, NULL};
    const char *const again[] = {"softsim-replay", "--convert", first, second, NULL};
    assert_int_equal(process_run(&child, once), 0);
    assert_int_equal(process_run(&child, again), 0);
    char command[300];
    snprintf(command, sizeof command, "cmp %s %s", first, second);
    assert_int_equal(system(command), 0);
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_poses *poses = NULL;
    softsim_pose_event event;
    char note[64];
    int count = 0;
    assert_int_equal(softsim_poses_open(first, 1000.0, &poses, &error), SOFTSIM_OK);
    while (softsim_poses_next(poses, &event, note, sizeof note) == SOFTSIM_POSES_POSE) {
        assert_int_equal(event.time_us, 1000 * count);
        assert_true(fabs(event.pose.position[0] - 1e-3 * count) < 1e-15);
        assert_int_equal(event.pose.seq, ++count);
    }
    softsim_poses_close(&poses);
    assert_int_equal(count, 1001);
}

/* ---- bridge ---- */

static bool close_the_loop(void)
{
    const char *csv = in_folder("b.csv");
    const char *const argv[] = {"softsim-bridge", "--device", "sim",   "--script", "press",
                                "--ticks",        "1500",     "--csv", csv,        "--offset-m",
                                "0.5,0.25,0.001", "--probe",  "1",     NULL};
    memset(&stand_in, 0, sizeof stand_in);
    stand_in.sends_rubbish = true;
    const long dropped_before = count_dropped();
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    await_poses(1500, dropped_before);
    stop_server();
    assert_true(stand_in.fresh <= 1500);
    bool was_touched = false;
    int32_t last_force_seq = -1, last_seq = 0;
    for (int i = 0; i < stand_in.fresh; ++i) {
        const softsim_pose *pose = &stand_in.kept[i];
        assert_true(pose->seq > last_seq && pose->seq <= 1500);
        last_seq = pose->seq;
        assert_true(pose->probe == 1 && pose->flags == SOFTSIM_POSE_CORRECTS);
        assert_true(fabs(pose->position[1] - 0.25) < 1e-3 && isnan(pose->velocity[0]));
        assert_true(pose->applied_force[2] >= 0.0 && pose->applied_force[2] < 6.0);
        assert_true(pose->force_seq >= last_force_seq || pose->force_seq == -1);
        last_force_seq = pose->force_seq;
        was_touched = was_touched || pose->applied_force[2] > 0.5;
    }
    /* The file's last column is the energy of its own force and motion. */
    FILE *file = fopen(csv, "r");
    assert_non_null(file);
    char line[1024];
    double before[14] = {0.0};
    double energy = 0.0;
    int count = 0, kept = 0;
    assert_non_null(fgets(line, sizeof line, file));
    while (fgets(line, sizeof line, file) != NULL) {
        double row[14];
        char *at = line;
        for (int k = 0; k < 14; ++k) {
            row[k] = strtod(at, &at);
            at += *at == ',';
        }
        if (count > 0) {
            for (int k = 0; k < 3; ++k) {
                energy -= before[10 + k] * (row[1 + k] - before[1 + k]);
            }
            assert_true(fabs(energy - before[13]) < 1e-12);
        }
        assert_true(row[0] == count);
        if (kept < stand_in.fresh && stand_in.kept[kept].seq == count + 1) { /* not lost */
            assert_true(fabs(row[9] - stand_in.kept[kept].position[2]) < 1e-15);
            ++kept;
        }
        memcpy(before, row, sizeof before);
        ++count;
    }
    fclose(file);
    assert_int_equal(count, 1500);
    assert_int_equal(kept, stand_in.fresh);
    return was_touched;
}

/* Forces that come late are let go of, by the contract: on a machine that holds one of the two back
 * the press may be felt only when it is done again. */
static void bridge_closes_the_loop(void **state)
{
    (void)state;
    for (int presses = 1; !close_the_loop(); ++presses) {
        assert_true(presses < 20);
    }
}

static void bridge_models_a_bad_bus(void **state)
{
    (void)state;
    const char *const argv[] = {"softsim-bridge",
                                "--device",
                                "sim",
                                "--ticks",
                                "800",
                                "--delay-ms",
                                "3",
                                "--loss",
                                "0.2",
                                "--jitter-ms",
                                "0.5",
                                "--correct",
                                "off",
                                "--script",
                                "slide",
                                NULL};
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    stop_server();
    /* A fifth lost each way and counted; the last few are still under way. */
    int forces = 0, lost = 0;
    const char *counts = strstr(child.out, "forces ");
    assert_non_null(counts);
    assert_int_equal(
        sscanf(counts, "forces %d received, %*d poses answered, %d messages", &forces, &lost), 2);
    assert_in_range(stand_in.poses, 101, 720);
    assert_in_range(forces, 1, stand_in.poses);
    assert_in_range(lost, 80, 800 - forces);
    double mean_us = 0.0;
    const char *latency = strstr(child.out, "latency_us  mean ");
    assert_non_null(latency);
    assert_int_equal(sscanf(latency, "latency_us  mean %lf", &mean_us), 1);
    assert_true(mean_us > 6000.0); /* there and back */
    assert_int_equal(stand_in.kept[100].flags, 0);
}

static void bridge_without_a_server_fails_and_says_so(void **state)
{
    (void)state;
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--ticks", "50", NULL};
    assert_int_equal(process_run(&child, argv), 1);
    assert_non_null(strstr(child.err, "no force came"));
}

/* Paced: it may be over before five seconds of silence are. */
static void a_run_without_any_answer_is_a_failure(void **state)
{
    (void)state;
    const char *log = in_folder("a.lcmlog");
    const char *const argv[] = {"softsim-replay", log, "--speed", "5", NULL};
    make_log(log, 50, 1);
    assert_int_equal(process_run(&child, argv), 1);
    assert_non_null(strstr(child.err, "no answer came; is softsimd running"));
    assert_non_null(strstr(child.out, "50 sent, 0 answered"));
    stand_in.other_until = INT32_MAX;
    start_server();
    /* It waits half a second for the last answer: a machine that holds the server back for longer
     * has it say what it saw before. */
    int runs = 0;
    do {
        assert_true(++runs < 20);
        assert_int_equal(process_run(&child, argv), 1);
    } while (strstr(child.err, "no answer came; is softsimd running") != NULL);
    assert_non_null(strstr(child.err, "no answer came: another sender holds the probe"));
}

static void bridge_tells_that_forces_stop(void **state)
{
    (void)state;
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--ticks", "2400", NULL};
    stand_in.mute_from = 300;
    stand_in.mute_until = INT32_MAX;
    start_server();
    process_start(&child, argv, NULL);
    expect_status(1);
    stop_server();
    double at_s = 0.0;
    const char *said = strstr(child.err, "forces stopped at");
    assert_non_null(said);
    assert_int_equal(sscanf(said, "forces stopped at %lf s", &at_s), 1);
    const double answered_s =
        1e-6 * (double)(stand_in.kept[298].utime_us - stand_in.kept[0].utime_us);
    assert_true(at_s > answered_s - 0.1 && at_s > 0.25);
    assert_null(strstr(child.err, "again"));

    /* A server that is held back meanwhile takes poses faster than they were sent: then its silence
     * is shorter, and it is asked again. */
    int runs = 0;
    do {
        assert_true(++runs < 20);
        memset(&stand_in, 0, sizeof stand_in);
        stand_in.mute_from = 300;
        stand_in.mute_until = 800;
        start_server();
        process_start(&child, argv, NULL);
        expect_status(0);
        stop_server();
        said = strstr(child.err, "forces again at");
        at_s = 0.0;
        if (said != NULL) {
            assert_non_null(strstr(child.err, "forces stopped at"));
            assert_int_equal(sscanf(said, "forces again at %*f s, after %lf s", &at_s), 1);
        }
    } while (at_s < 0.4);
}

static void bridge_tells_whose_the_probe_is(void **state)
{
    (void)state;
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--ticks", "800", NULL};
    stand_in.other_until = 400;
    stand_in.is_entering = true; /* not by its own doing: no hint */
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    stop_server();
    int forces = 0, answered = 0;
    const char *at = strstr(child.out, "forces ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "forces %d received, %d poses", &forces, &answered), 2);
    assert_in_range(forces, 1, stand_in.fresh - 399); /* the others are none */
    assert_int_equal(answered, forces);
    double held_s = 0.0;
    at = strstr(child.out, "another sender held it for");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "another sender held it for %lf s", &held_s), 1);
    assert_true(held_s > 0.35);
    assert_null(strstr(child.err, "inside"));

    memset(&stand_in, 0, sizeof stand_in);
    stand_in.other_until = INT32_MAX;
    start_server();
    process_start(&child, argv, NULL);
    expect_status(1);
    assert_non_null(strstr(child.err, "no force came: another sender held the probe for"));
}

static void bridge_tells_that_it_began_inside(void **state)
{
    (void)state;
    const char *const argv[] = {"softsim-bridge", "--device", "sim", "--ticks", "300", NULL};
    stand_in.is_entering = true;
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    assert_non_null(strstr(child.err, "the hand started inside the tissue"));
    stop_server();
    memset(&stand_in, 0, sizeof stand_in);
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    assert_null(strstr(child.err, "inside"));
}

/* ---- monitor, arguments ---- */

static void monitor_believes_only_whole_messages(void **state)
{
    (void)state;
    const char *const argv[] = {"softsim-monitor", "--once", "--json", NULL};
    stand_in.sends_status = true;
    start_server();
    process_start(&child, argv, NULL);
    expect_status(0);
    stop_server();
    assert_non_null(strstr(child.out, "\"scene\": \"stand-in.yaml\", \"model\": \"linear\", "
                                      "\"reason\": \"\"}\n"));
    assert_non_null(strstr(child.out, "\"uptime_s\": 2.5"));
}

static void monitor_tells_that_nobody_is_there(void **state)
{
    (void)state;
    const char *const argv[] = {"softsim-monitor", "--duration", "0.3", NULL};
    assert_int_equal(process_run(&child, argv), 1);
    assert_non_null(strstr(child.err, "no status for 0.3"));
    assert_int_equal(process_finish(&patient), 1);
    const char *said = strstr(patient.err, "no status for 2 s; is softsimd running");
    assert_non_null(said);
    assert_null(strstr(said + 1, "no status")); /* once */
    assert_non_null(strstr(patient.err, "gave up after 10 s"));
    assert_int_equal(process_finish(&asking), 1);
    assert_non_null(strstr(asking.err, "no reply for 3 s"));
}

/* Started first and asked last: they take their time. */
static int start_patient(void **state)
{
    (void)state;
    const char *const once[] = {"softsim-monitor", "--once", "--prefix", "NOBODY", NULL};
    const char *const pause[] = {"softsim-monitor", "--command", "pause",
                                 "--prefix",        "NOBODY",    NULL};
    process_start(&patient, once, NULL);
    process_start(&asking, pause, NULL);
    return 0;
}

static int stop_patient(void **state)
{
    (void)state;
    process *all[] = {&patient, &asking};
    for (int i = 0; i < 2; ++i) {
        process_signal(all[i], SIGKILL);
        process_finish(all[i]);
    }
    return 0;
}

static void a_machine_without_a_route_is_told(void **state)
{
    (void)state;
    static const char *const programs[] = {"softsim-bridge --device sim --ticks 5",
                                           "softsim-monitor --once", "softsim-replay"};
    const char *log = in_folder("a.lcmlog");
    make_log(log, 3, 1);
    for (int i = 0; i < 3; ++i) {
        char command[512];
        char text[4096];
        snprintf(command, sizeof command, "unshare -n %s/%s %s 2>&1", BIN_DIR, programs[i],
                 i == 2 ? log : "");
        FILE *pipe = popen(command, "r");
        assert_non_null(pipe);
        text[fread(text, 1, sizeof text - 1, pipe)] = '\0';
        const int status = pclose(pipe);
        assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 1);
        assert_non_null(strstr(text, "ip route add 224.0.0.0/4 dev lo"));
    }
}

static void bad_arguments_are_all_named(void **state)
{
    (void)state;
    const char *log = in_folder("a.lcmlog");
    const char *bad = in_folder("bad.lcmlog");
    make_log(log, 3, 1);
    FILE *file = fopen(bad, "w");
    assert_non_null(file);
    fputs("this is no log", file);
    fclose(file);
    const struct {
        const char *argv[12];
        const char *said;
        int lines;
    } cases[] = {
        {{"softsim-replay", log, log}, "--convert", 1},
        {{"softsim-replay", "--convert", log}, "--convert needs two files", 1},
        {{"softsim-replay", log, "--lockstep", "--speed", "2"}, "--speed", 1},
        {{"softsim-replay", log, "--repeat", "0", "--rate", "x"}, "--rate", 2},
        {{"softsim-replay", log, "--prefix", "a.*"}, "prefix", 1},
        {{"softsim-replay", log, "--prefix", ""}, "prefix", 1},
        {{"softsim-replay", bad}, "no probe poses", 2},
        {{"softsim-replay", folder}, "a folder, not a file", 1},
        {{"softsim-replay", log, "--nonsense"}, "--nonsense", 1},
        {{"softsim-replay", "--nonsense"}, "--nonsense", 1},
        {{"softsim-replay", "--nonsense", "3", "4", log}, "--nonsense", 1},
        {{"softsim-replay", log, "--repeat"}, "--repeat needs a value", 1},
        {{"softsim-bridge", "--device", "wand"}, "wand", 1},
        {{"softsim-bridge", "--device", "script"}, "--path", 1},
        {{"softsim-bridge", "--device", "sim", "--path", log}, "--path", 1},
        {{"softsim-bridge", "--device", "sim", "--delay-ticks", "2"}, "--delay-ticks", 1},
        {{"softsim-bridge", "--device", "sim", "--linear-tissue", "5", "--delay-ms", "1"},
         "--linear-tissue",
         1},
        {{"softsim-bridge", "--device", "sim", "--body", "huge", "--loss", "2"}, "--loss", 2},
        {{"softsim-bridge", "--device", "sim", "--axes", "x,y", "--offset-m", "a"},
         "--offset-m",
         2},
        {{"softsim-bridge", "--device", "script", "--path", "/nowhere/p.csv"}, "/nowhere/p.csv", 1},
        {{"softsim-monitor", "--duration", "-1"}, "--duration", 1},
        {{"softsim-monitor", "more"}, "more", 1},
        {{"softsim-monitor", "--command", "pause", "--once"}, "--command", 1},
        {{"softsim-monitor", "--command", ""}, "--command: give NAME", 1},
        {{"softsim-monitor", "--command", "set a=\x1b[2J"}, "--command: give NAME", 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const int status = process_run(&child, cases[i].argv);
        int lines = 0;
        for (const char *at = child.err; (at = strchr(at, '\n')) != NULL; ++at) {
            ++lines;
        }
        if (status != 2 || strstr(child.err, cases[i].said) == NULL || lines != cases[i].lines) {
            fail_msg("%s, case %zu: status %d: %s", cases[i].argv[0], i, status, child.err);
        }
        assert_int_equal(child.out_size, 0);
    }
    static const char *const programs[] = {"softsim-replay", "softsim-bridge", "softsim-monitor"};
    for (int i = 0; i < 3; ++i) {
        const char *const help[] = {programs[i], "--help", NULL};
        const char *const version[] = {programs[i], "--version", NULL};
        assert_int_equal(process_run(&child, help), 0);
        assert_non_null(strstr(child.out, "--lcm-url"));
        assert_int_equal(process_run(&child, version), 0);
        assert_non_null(strstr(child.out, programs[i]));
    }
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(lockstep_answers_every_pose_once),
        TEST(paced_replay_keeps_the_answers),
        TEST(pose_csv_is_replayed),
        TEST(silence_is_a_failure),
        TEST(stopped_replay_keeps_its_files),
        TEST(a_killed_replay_leaves_what_it_recorded),
        TEST(a_stopped_bridge_keeps_its_file),
        TEST(a_killed_bridge_leaves_what_it_recorded),
        TEST(a_hangup_ends_in_order),
        TEST(closed_descriptors_write_into_no_file),
        TEST(monitor_shows_force_and_indentation),
        TEST(damaged_logs_are_played_and_named),
        TEST(conversion_is_reproducible),
        TEST(bridge_closes_the_loop),
        TEST(bridge_models_a_bad_bus),
        TEST(bridge_without_a_server_fails_and_says_so),
        TEST(a_run_without_any_answer_is_a_failure),
        TEST(bridge_tells_that_forces_stop),
        TEST(bridge_tells_whose_the_probe_is),
        TEST(bridge_tells_that_it_began_inside),
        TEST(monitor_believes_only_whole_messages),
        TEST(a_machine_without_a_route_is_told),
        TEST(bad_arguments_are_all_named),
        TEST(monitor_tells_that_nobody_is_there),
    };
    return PROCESS_RUN_GROUP("clients_lcm", tests, start_patient, stop_patient);
}
