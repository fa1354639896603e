/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Clients without a network: logs, pose paths, frames, corrector, bus, simulated device, JSON. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bridge.h"
#include "output.h"
#include "random.h"
#include "rt/vec.h"
#include "show.h"
#include "softsim/log.h"
#include "wire.h"

#define assert_near(a, b, tolerance)                                                               \
    do {                                                                                           \
        const double near_a = (a), near_b = (b), near_t = (tolerance);                             \
        if (!(fabs(near_a - near_b) <= near_t)) {                                                  \
            fail_msg("%s = %.17g, not %.17g within %g", #a, near_a, near_b, near_t);               \
        }                                                                                          \
    } while (0)

static char folder[64];

static int make_folder(void **state)
{
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/softsim-clients-XXXXXX");
    return mkdtemp(folder) != NULL ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}

static const char *in_folder(const char *name)
{
    static char path[160];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void write_file(const char *path, const void *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static size_t read_file(const char *path, unsigned char *data, size_t capacity)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(data, 1, capacity, file);
    fclose(file);
    return size;
}

/* ---- event logs --------------------------------------------------------------------------------
 */

enum { POSES = 40, RECORD = 28 + 15 + SS_WIRE_POSE_SIZE, LOG_SIZE = POSES * RECORD };

static softsim_pose make_pose(int32_t seq)
{
    return (softsim_pose){.utime_us = 1000 * seq,
                          .sender = 77,
                          .seq = seq,
                          .probe = 0,
                          .buttons = seq & 1,
                          .force_seq = seq - 1,
                          .flags = 1,
                          .position = {0.001 * seq, -0.25, 1.0 / 3.0},
                          .orientation = {1.0, 0.0, 0.0, 0.0},
                          .velocity = {NAN, NAN, NAN},
                          .applied_force = {0.5, 0.0, -0.5}};
}

/* A log of POSES good poses; its bytes into `data`. */
static void make_log(const char *path, unsigned char data[LOG_SIZE])
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    assert_int_equal(softsim_log_create(path, &writer, &error), SOFTSIM_OK);
    for (int32_t i = 0; i < POSES; ++i) {
        const softsim_pose pose = make_pose(i + 1);
        softsim_log_write_pose(writer, 1000000 + 1000 * i, "SOFTSIM_PROBE_0", &pose);
    }
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
    assert_int_equal(read_file(path, data, LOG_SIZE), LOG_SIZE);
}

typedef struct tally {
    int events, damaged, truncated;
    int64_t bytes, skipped, first_fault;
} tally;

/* Reads a log to its end; checks that records and damage cover every byte once. */
static tally read_log(const char *path)
{
    tally found = {.first_fault = -1};
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *log = NULL;
    assert_int_equal(softsim_log_open(path, &log, &error), SOFTSIM_OK);
    softsim_log_event event;
    softsim_log_result result;
    while ((result = softsim_log_next(log, &event)) != SOFTSIM_LOG_END) {
        assert_int_equal(event.offset, found.bytes);
        if (result == SOFTSIM_LOG_EVENT) {
            ++found.events;
            found.bytes += 28 + (int64_t)strlen(event.channel) + event.data_size;
            continue;
        }
        assert_int_not_equal(result, SOFTSIM_LOG_UNREADABLE);
        assert_true(event.skipped > 0);
        found.damaged += result == SOFTSIM_LOG_DAMAGED;
        found.truncated += result == SOFTSIM_LOG_TRUNCATED;
        found.first_fault = found.first_fault < 0 ? event.offset : found.first_fault;
        found.skipped += event.skipped;
        found.bytes += event.skipped;
    }
    softsim_log_close(&log);
    return found;
}

static void put32(unsigned char *at, uint32_t value)
{
    for (int i = 0; i < 4; ++i) {
        at[i] = (unsigned char)(value >> (24 - 8 * i));
    }
}

static void log_gives_back_what_was_written(void **state)
{
    (void)state;
    unsigned char data[LOG_SIZE];
    const char *path = in_folder("good.lcmlog");
    make_log(path, data);
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log *log = NULL;
    assert_int_equal(softsim_log_open(path, &log, &error), SOFTSIM_OK);
    softsim_log_event event;
    for (int32_t i = 0; i < POSES; ++i) {
        softsim_pose pose;
        const softsim_pose expected = make_pose(i + 1);
        uint8_t bytes[2][SS_WIRE_POSE_SIZE];
        assert_int_equal(softsim_log_next(log, &event), SOFTSIM_LOG_EVENT);
        assert_int_equal(event.number, i);
        assert_int_equal(event.utime_us, 1000000 + 1000 * i);
        assert_string_equal(event.channel, "SOFTSIM_PROBE_0");
        assert_true(softsim_log_decode_pose(event.data, event.data_size, &pose));
        ss_wire_encode_pose(&pose, bytes[0]);
        ss_wire_encode_pose(&expected, bytes[1]);
        assert_memory_equal(bytes[0], bytes[1], SS_WIRE_POSE_SIZE);
        assert_int_equal(pose.seq, expected.seq);
        assert_true(isnan(pose.velocity[0]) && pose.position[2] == 1.0 / 3.0);
    }
    assert_int_equal(softsim_log_next(log, &event), SOFTSIM_LOG_END);
    softsim_log_close(&log);
}

static void log_format_is_lcms(void **state)
{
    (void)state;
    unsigned char data[LOG_SIZE];
    make_log(in_folder("good.lcmlog"), data);
    static const unsigned char head[28] = {
        0xED, 0xA1, 0xDA, 0x01, 0,    0,    0, 0, 0, 0,  0, 0, 0, 0,
        0,    0,    0,    0x0F, 0x42, 0x40, 0, 0, 0, 15, 0, 0, 0, SS_WIRE_POSE_SIZE};
    assert_memory_equal(data, head, sizeof head);
}

static void every_truncation_is_reported(void **state)
{
    (void)state;
    unsigned char data[LOG_SIZE];
    const char *path = in_folder("cut.lcmlog");
    make_log(path, data);
    for (size_t size = 0; size <= 3 * RECORD; ++size) {
        write_file(path, data, size);
        const tally found = read_log(path);
        assert_int_equal(found.events, size / RECORD);
        assert_int_equal(found.truncated, size % RECORD != 0);
        assert_int_equal(found.damaged, 0);
        assert_int_equal(found.skipped, size % RECORD);
    }
}

static void damage_costs_one_record(void **state)
{
    (void)state;
    static const struct {
        const char *what;
        int offset; /* in the record */
        uint32_t value;
    } cases[] = {
        {"magic", 0, 0xEDA1DA02u},
        {"channel length 0", 20, 0},
        {"channel length 64", 20, 64},
        {"channel length negative", 20, 0xFFFFFFFFu},
        {"channel length 0x7fffffff", 20, 0x7FFFFFFFu},
        {"data length 0x7ffffffe", 24, 0x7FFFFFFEu},
        {"data length 0x7fffffff", 24, 0x7FFFFFFFu},
        {"data length negative", 24, 0x80000000u},
        {"data length -1", 24, 0xFFFFFFFFu},
        {"data length a bit too long", 24, SS_WIRE_POSE_SIZE + 5},
        {"data length a record and a bit too long", 24, SS_WIRE_POSE_SIZE + RECORD + 5},
        {"data length beyond the file", 24, LOG_SIZE},
        {"channel with a NUL", 28, 0x00464653u},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        for (int record = 0; record < POSES; record += POSES / 2 - 1) {
            unsigned char data[LOG_SIZE];
            const char *path = in_folder("bad.lcmlog");
            make_log(path, data);
            put32(data + record * RECORD + cases[i].offset, cases[i].value);
            write_file(path, data, LOG_SIZE);
            const tally found = read_log(path);
            if (found.events != POSES - 1 || found.damaged != 1 || found.skipped != RECORD ||
                found.first_fault != record * RECORD) {
                fail_msg("%s, record %d: %d events, %d damaged, %lld bytes at %lld", cases[i].what,
                         record, found.events, found.damaged, (long long)found.skipped,
                         (long long)found.first_fault);
            }
        }
    }
}

static void a_length_too_short_keeps_the_others(void **state)
{
    (void)state;
    unsigned char data[LOG_SIZE];
    const char *path = in_folder("short.lcmlog");
    make_log(path, data);
    put32(data + 5 * RECORD + 24, 100);
    write_file(path, data, LOG_SIZE);
    const tally found = read_log(path);
    assert_int_equal(found.events, POSES); /* one of them too short to be a pose */
    assert_int_equal(found.skipped, SS_WIRE_POSE_SIZE - 100);
}

static void any_bytes_are_survived(void **state)
{
    (void)state;
    uint64_t random = 12345;
    for (int round = 0; round < 400; ++round) {
        unsigned char data[LOG_SIZE];
        const char *path = in_folder("fuzz.lcmlog");
        make_log(path, data);
        for (int i = 0; i < 30; ++i) {
            data[ss_random_next(&random) % LOG_SIZE] = (unsigned char)ss_random_next(&random);
        }
        const size_t size = ss_random_next(&random) % (LOG_SIZE + 1);
        write_file(path, data, size);
        const tally found = read_log(path);
        assert_int_equal(found.bytes, size);
    }
}

static void a_log_of_fake_headers_is_read_in_linear_time(void **state)
{
    (void)state;
    /* 30,000 headers, each claiming a payload that covers the next 5,000. */
    enum { COUNT = 30000, SIZE = 29 };
    unsigned char *data = calloc(COUNT, SIZE);
    assert_non_null(data);
    for (int i = 0; i < COUNT; ++i) {
        put32(data + i * SIZE, 0xEDA1DA01u);
        put32(data + i * SIZE + 20, 1);
        put32(data + i * SIZE + 24, 5000 * SIZE + 7);
        data[i * SIZE + 28] = 'a';
    }
    const char *path = in_folder("fake.lcmlog");
    write_file(path, data, (size_t)COUNT * SIZE);
    free(data);
    const tally found = read_log(path);
    assert_int_equal(found.bytes, (int64_t)COUNT * SIZE);
}

static void large_payloads_are_passed_over(void **state)
{
    (void)state;
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    softsim_log *log = NULL;
    softsim_log_event event;
    enum { LARGE = 3 * 1024 * 1024 };
    char *large = calloc(1, LARGE);
    const softsim_pose pose = make_pose(1);
    const char *path = in_folder("large.lcmlog");
    assert_int_equal(softsim_log_create(path, &writer, &error), SOFTSIM_OK);
    softsim_log_write(writer, 1, "CAMERA", large, LARGE);
    softsim_log_write_pose(writer, 2, "SOFTSIM_PROBE_0", &pose);
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
    free(large);
    assert_int_equal(softsim_log_open(path, &log, &error), SOFTSIM_OK);
    assert_int_equal(softsim_log_next(log, &event), SOFTSIM_LOG_EVENT);
    assert_null(event.data);
    assert_int_equal(event.data_size, LARGE);
    assert_int_equal(softsim_log_next(log, &event), SOFTSIM_LOG_EVENT);
    assert_int_equal(event.data_size, SS_WIRE_POSE_SIZE);
    softsim_log_close(&log);
}

static void probe_channels_have_any_prefix(void **state)
{
    (void)state;
    static const struct {
        const char *channel;
        int32_t probe;
    } cases[] = {{"SOFTSIM_PROBE_0", 0}, {"a_PROBE_7", 7},  {"A_B_PROBE_3", 3},  {"_PROBE_3", -1},
                 {"PROBE_3", -1},        {"X_PROBE_8", -1}, {"X_PROBE_", -1},    {"X_PROBE_10", -1},
                 {"X_PROBE_1x", -1},     {"X_FORCE_1", -1}, {"X_PROBE_\x31", 1}, {"", -1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        assert_int_equal(softsim_log_probe(cases[i].channel), cases[i].probe);
    }
}

static void only_exact_messages_are_decoded(void **state)
{
    (void)state;
    uint8_t bytes[SS_WIRE_FORCE_SIZE + 1] = {0};
    const softsim_pose pose = make_pose(3);
    softsim_pose out_pose;
    ss_wire_encode_pose(&pose, bytes);
    assert_true(softsim_log_decode_pose(bytes, SS_WIRE_POSE_SIZE, &out_pose));
    for (int32_t size = -1; size <= SS_WIRE_FORCE_SIZE; ++size) {
        assert_int_equal(softsim_log_decode_pose(bytes, size, &out_pose),
                         size == SS_WIRE_POSE_SIZE);
    }
    assert_false(softsim_log_decode_pose(NULL, SS_WIRE_POSE_SIZE, &out_pose));
    for (int i = 0; i < 64; ++i) { /* every bit of the type hash counts */
        bytes[i / 8] ^= (uint8_t)(1u << (i % 8));
        assert_false(softsim_log_decode_pose(bytes, SS_WIRE_POSE_SIZE, &out_pose));
        bytes[i / 8] ^= (uint8_t)(1u << (i % 8));
    }
    const softsim_force force = {.sender = -5, .seq = 9, .stiffness = 300.0, .proxy = {1, 2, 3}};
    softsim_force out_force;
    ss_wire_encode_force(&force, bytes);
    assert_true(softsim_log_decode_force(bytes, SS_WIRE_FORCE_SIZE, &out_force));
    assert_memory_equal(&force, &out_force, sizeof force);
    assert_false(softsim_log_decode_force(bytes, SS_WIRE_FORCE_SIZE + 1, &out_force));
    assert_false(softsim_log_decode_pose(bytes, SS_WIRE_POSE_SIZE, &out_pose));
}

static void output_is_complete_or_absent(void **state)
{
    (void)state;
    softsim_error error = {.status = SOFTSIM_OK};
    ss_output output;
    const char *path = in_folder("out.txt");
    assert_int_equal(ss_output_open(&output, path, &error), SOFTSIM_OK);
    fputs("half", output.file);
    assert_int_equal(access(path, F_OK), -1);
    ss_output_abandon(&output);
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(ss_output_open(&output, path, &error), SOFTSIM_OK);
    assert_int_equal(ss_output_commit(&output, &error), SOFTSIM_OK);
    assert_int_equal(access(path, F_OK), 0);
    assert_int_equal(ss_output_open(&output, in_folder("no/such"), &error), SOFTSIM_ERROR_FILE);
    assert_int_equal(ss_output_commit(&output, &error), SOFTSIM_OK); /* not open: nothing */
    if (access("/dev/full", W_OK) == 0) { /* a full disk is noticed, by whichever write */
        assert_int_equal(ss_output_open(&output, in_folder("full"), &error), SOFTSIM_OK);
        assert_non_null(freopen("/dev/full", "wb", output.file));
        fputs("lost", output.file);
        assert_int_equal(ss_output_commit(&output, &error), SOFTSIM_ERROR_FILE);
        assert_int_equal(access(in_folder("full"), F_OK), -1);
    }
}

/* ---- pose paths
 * ---------------------------------------------------------------------------------- */

#define CSV_HEADER "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n"

static void csv_faults_name_their_line(void **state)
{
    (void)state;
    static const struct {
        const char *rows;
        const char *fault; /* in the message, behind the file's name */
    } cases[] = {
        {"", ": no poses"},
        {"0,0,0,0,0,1,0,0,0\n", ":2: 9 columns"},
        {"0,0,0,0,0,1,0,0,0,0,0\n", ":2: 11 columns"},
        {"0,0,0,0,0,1,0,0,0,0\n0,0,0,0,0,1,0,0,0,0\n", ":3: time_s 0 does not grow"},
        {"1,0,0,0,0,1,0,0,0,0\n\n0.5,0,0,0,0,1,0,0,0,0\n", ":4: time_s 0.5 does not grow"},
        {"0,8,0,0,0,1,0,0,0,0\n", ":2: probe 8"},
        {"0,0.5,0,0,0,1,0,0,0,0\n", ":2: probe 0.5"},
        {"0,-1,0,0,0,1,0,0,0,0\n", ":2: probe -1"},
        {"-1,0,0,0,0,1,0,0,0,0\n", ":2: time_s -1"},
        {"0,0,nan,0,0,1,0,0,0,0\n", ":2: column 3"},
        {"0,0,0,inf,0,1,0,0,0,0\n", ":2: column 4"},
        {"0,0,0,,0,1,0,0,0,0\n", ":2: column 4"},
        {"0,0,0,1 2,0,1,0,0,0,0\n", ":2: column 4"},
        {"0,0,0,0,2000,1,0,0,0,0\n", ":2: position 2000 m"},
        {"0,0,0,0,0,1.01,0,0,0,0\n", ":2: quaternion of length 1.01"},
        {"0,0,0,0,0,0,0,0,0,0\n", ":2: quaternion of length 0"},
        {"0,0,0,0,0,1,0,0,0,0.5\n", ":2: buttons 0.5"},
        {"0,0,0,0,0,1,0,0,0,-1\n", ":2: buttons -1"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char text[512];
        softsim_error error = {.status = SOFTSIM_OK};
        softsim_path *path = NULL;
        snprintf(text, sizeof text, "%s%s", CSV_HEADER, cases[i].rows);
        write_file(in_folder("bad.csv"), text, strlen(text));
        assert_int_equal(softsim_path_load(in_folder("bad.csv"), &path, &error),
                         SOFTSIM_ERROR_FORMAT);
        assert_null(path);
        assert_int_equal(error.fault_count, 1);
        if (strstr(error.text, cases[i].fault) == NULL) {
            fail_msg("'%s' is not in: %s", cases[i].fault, error.text);
        }
    }
}

static void csv_names_all_its_faults(void **state)
{
    (void)state;
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_path *path = NULL;
    static const char text[] = CSV_HEADER "0,9,0,0,0,1,0,0,0,0\n1,0,0,0,0,1,0,0,0,0\nx\n";
    write_file(in_folder("bad.csv"), text, strlen(text));
    assert_int_equal(softsim_path_load(in_folder("bad.csv"), &path, &error), SOFTSIM_ERROR_FORMAT);
    assert_int_equal(error.fault_count, 2);
    assert_non_null(strstr(error.text, ":2: "));
    assert_non_null(strstr(error.text, ":4: "));
    static const char other[] = "t,x,y\n0,0,0\n";
    write_file(in_folder("bad.csv"), other, strlen(other));
    error = (softsim_error){.status = SOFTSIM_OK};
    assert_int_equal(softsim_path_load(in_folder("bad.csv"), &path, &error), SOFTSIM_ERROR_FORMAT);
    assert_non_null(strstr(error.text, ":1: "));
    error = (softsim_error){.status = SOFTSIM_OK};
    assert_int_equal(softsim_path_load(in_folder("none.csv"), &path, &error), SOFTSIM_ERROR_FILE);
}

static void path_is_interpolated(void **state)
{
    (void)state;
    /* A quarter turn about z while moving along x; CRLF ends. */
    static const char text[] = "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\r\n"
                               "1,2,0,0,0.5,1,0,0,0,1\r\n"
                               "3,2,0.2,0,0.5,0.70710678118654752,0,0,0.70710678118654752,0\r\n";
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_path *path = NULL;
    softsim_pose pose;
    write_file(in_folder("path.csv"), text, strlen(text));
    assert_int_equal(softsim_path_load(in_folder("path.csv"), &path, &error), SOFTSIM_OK);
    assert_int_equal(softsim_path_probes(path), 1 << 2);
    assert_false(softsim_path_sample(path, 2, 0.999, &pose));
    assert_false(softsim_path_sample(path, 2, 3.001, &pose));
    assert_false(softsim_path_sample(path, 2, NAN, &pose));
    assert_false(softsim_path_sample(path, 1, 2.0, &pose));
    for (int i = 0; i <= 100; ++i) {
        const double u = i / 100.0;
        const double half = u * 0.78539816339744831 / 1.0 * 0.5 * 2.0; /* half of u times 90 deg */
        assert_true(softsim_path_sample(path, 2, 1.0 + 2.0 * u, &pose));
        assert_near(pose.position[0], 0.2 * u, 1e-15);
        assert_near(pose.position[2], 0.5, 0.0);
        assert_near(pose.orientation[0], cos(half), 1e-12);
        assert_near(pose.orientation[3], sin(half), 1e-12);
        assert_int_equal(pose.buttons, i < 100);
        assert_true(isnan(pose.velocity[0]) && pose.force_seq == -1);
    }
    softsim_path_free(&path);
}

static void quaternions_take_the_short_way(void **state)
{
    (void)state;
    /* q and -q are the same orientation: between them nothing turns. */
    static const char text[] = CSV_HEADER "0,0,0,0,0,0.6,0.8,0,0,0\n1,0,0,0,0,-0.6,-0.8,0,0,0\n";
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_path *path = NULL;
    softsim_pose pose;
    write_file(in_folder("path.csv"), text, strlen(text));
    assert_int_equal(softsim_path_load(in_folder("path.csv"), &path, &error), SOFTSIM_OK);
    assert_true(softsim_path_sample(path, 0, 0.5, &pose));
    assert_near(pose.orientation[0], 0.6, 1e-15);
    assert_near(pose.orientation[1], 0.8, 1e-15);
    softsim_path_free(&path);
}

/* ---- poses of either
 * ------------------------------------------------------------------------------ */

static void csv_is_sampled_on_the_ticks(void **state)
{
    (void)state;
    static const char text[] = CSV_HEADER "0.0101,0,0,0,0,1,0,0,0,0\n0.2,0,1,0,0,1,0,0,0,0\n"
                                          "0.1,5,0,0,0,1,0,0,0,0\n0.2,5,0,0,0,1,0,0,0,0\n";
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_poses *poses = NULL;
    softsim_pose_event event;
    char note[64];
    write_file(in_folder("path.csv"), text, strlen(text));
    assert_int_equal(softsim_poses_open(in_folder("path.csv"), 1000.0, &poses, &error), SOFTSIM_OK);
    for (int turn = 0; turn < 2; ++turn) {
        int count[8] = {0};
        int64_t last_us = 0;
        while (softsim_poses_next(poses, &event, note, sizeof note) == SOFTSIM_POSES_POSE) {
            const double time_s = 0.011 + 1e-6 * (double)event.time_us;
            assert_int_equal(event.channel_probe, event.pose.probe);
            assert_true(event.time_us == last_us || event.time_us == last_us + 1000);
            if (event.pose.probe == 0) {
                assert_near(event.pose.position[0], (time_s - 0.0101) / (0.2 - 0.0101), 1e-12);
            }
            ++count[event.channel_probe];
            last_us = event.time_us;
        }
        assert_int_equal(count[0], 190); /* 0.011 .. 0.200 */
        assert_int_equal(count[5], 101); /* 0.100 .. 0.200 */
        softsim_poses_rewind(poses);
    }
    softsim_poses_close(&poses);
}

static void log_poses_keep_their_times(void **state)
{
    (void)state;
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    softsim_poses *poses = NULL;
    const char *path = in_folder("times.lcmlog");
    static const struct {
        int64_t utime_us;
        int64_t time_us; /* expected */
        bool is_noted;
    } cases[] = {{5000, 0, false},        {6000, 1000, false},     {5500, 1000, true},
                 {6500, 2000, false},     {90000000, 2000, true},  {90001000, 3000, false},
                 {INT64_MIN, 3000, true}, {INT64_MAX, 3000, true}, {INT64_MAX, 3000, false}};
    const int count = sizeof cases / sizeof cases[0];
    assert_int_equal(softsim_log_create(path, &writer, &error), SOFTSIM_OK);
    for (int i = 0; i < count; ++i) {
        const softsim_pose pose = make_pose(i + 1);
        softsim_log_write(writer, 0, "SOFTSIM_STATUS", "xyz", 3);
        softsim_log_write_pose(writer, cases[i].utime_us, "OTHER_PROBE_4", &pose);
        softsim_log_write(writer, 0, "SOFTSIM_PROBE_0", "not a pose", 10);
    }
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
    assert_int_equal(softsim_poses_open(path, 1000.0, &poses, &error), SOFTSIM_OK);
    for (int i = 0; i < count; ++i) {
        softsim_pose_event event;
        char note[256] = "";
        if (cases[i].is_noted) {
            assert_int_equal(softsim_poses_next(poses, &event, note, sizeof note),
                             SOFTSIM_POSES_NOTE);
            assert_non_null(strstr(note, "jumps"));
        }
        assert_int_equal(softsim_poses_next(poses, &event, note, sizeof note), SOFTSIM_POSES_POSE);
        assert_int_equal(event.time_us, cases[i].time_us);
        assert_int_equal(event.channel_probe, 4);
        assert_int_equal(event.pose.seq, i + 1);
        assert_int_equal(softsim_poses_next(poses, &event, note, sizeof note), SOFTSIM_POSES_NOTE);
        assert_non_null(strstr(note, "no probe_pose_t"));
    }
    softsim_poses_close(&poses);
}

static void restamped_poses_are_a_new_senders(void **state)
{
    (void)state;
    softsim_pose pose = make_pose(17);
    pose.velocity[1] = 0.25;
    softsim_poses_restamp(&pose, 99, 1);
    assert_true(pose.sender == 99 && pose.seq == 1 && pose.force_seq == -1 && pose.flags == 0);
    assert_true(isnan(pose.applied_force[0]) && isnan(pose.applied_force[2]));
    assert_true(pose.velocity[1] == 0.25 && pose.buttons == 1 && pose.position[0] == 0.017);
}

/* ---- frame
 * --------------------------------------------------------------------------------------- */

static void axes_are_signed_permutations(void **state)
{
    (void)state;
    static const struct {
        const char *axes;
        double image[3]; /* world position of the device's (1, 2, 3); 0,0,0: refused */
    } cases[] = {
        {"x,y,z", {1, 2, 3}},   {"x,-z,y", {1, -3, 2}}, {"-y,+x,z", {-2, 1, 3}},
        {"z,x,-y", {3, 1, -2}}, {"x,x,z", {0, 0, 0}},   {"x,y", {0, 0, 0}},
        {"x,y,z,", {0, 0, 0}},  {"x y z", {0, 0, 0}},   {"", {0, 0, 0}},
        {"x,y,w", {0, 0, 0}},   {"--x,y,z", {0, 0, 0}}, {"X,Y,Z", {0, 0, 0}},
        {"x,y,z ", {0, 0, 0}},  {"-", {0, 0, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        softsim_error error = {.status = SOFTSIM_OK};
        ss_frame frame;
        const double device[3] = {1, 2, 3};
        double world[3];
        const bool is_good =
            ss_frame_init(&frame, cases[i].axes, "0,0,0", 1.0, 1.0, &error) == SOFTSIM_OK;
        assert_int_equal(is_good, cases[i].image[0] != 0);
        assert_int_equal(error.fault_count, !is_good);
        if (is_good) {
            ss_frame_position(&frame, device, world);
            assert_memory_equal(world, cases[i].image, sizeof world);
        }
    }
    static const char *const offsets[] = {"1,2",     "1,2,3,",  "1,2,x", "",
                                          "nan,0,0", "1e9,0,0", "1 2 3"};
    for (size_t i = 0; i < sizeof offsets / sizeof offsets[0]; ++i) {
        softsim_error error = {.status = SOFTSIM_OK};
        ss_frame frame;
        assert_int_equal(ss_frame_init(&frame, "x,y,z", offsets[i], 1.0, 1.0, &error),
                         SOFTSIM_ERROR_ARGUMENT);
    }
}

static void frames_are_consistent(void **state)
{
    (void)state;
    static const char *const permutations[] = {"x,y,z", "x,z,y", "y,x,z",
                                               "y,z,x", "z,x,y", "z,y,x"};
    uint64_t random = 7;
    for (int i = 0; i < 48; ++i) {
        const char *p = permutations[i / 8];
        char axes[16];
        softsim_error error = {.status = SOFTSIM_OK};
        ss_frame frame;
        snprintf(axes, sizeof axes, "%s%c,%s%c,%s%c", i & 1 ? "-" : "", p[0], i & 2 ? "-" : "",
                 p[2], i & 4 ? "-" : "", p[4]);
        assert_int_equal(ss_frame_init(&frame, axes, "0.1,-0.2,0.3", 2.0, 0.5, &error), SOFTSIM_OK);
        double q[4], at[3], force[3], world[3], turned[3], device_force[3], direct[3], q_world[4];
        for (int k = 0; k < 4; ++k) {
            q[k] = ss_random_unit(&random) - 0.5;
        }
        const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (int k = 0; k < 4; ++k) {
            q[k] /= length;
        }
        for (int k = 0; k < 3; ++k) {
            at[k] = ss_random_unit(&random) - 0.5;
            force[k] = ss_random_unit(&random) - 0.5;
        }
        /* The tool's z axis points in the world where the device's tool axis points; its x axis
         * too, unless the frame is a mirror. */
        ss_frame_orientation(&frame, q, q_world);
        for (int axis = 2; axis >= 0; axis -= 2) {
            double unit[3] = {0.0, 0.0, 0.0};
            unit[axis] = 1.0;
            ss_rotate(direct, q, unit);
            ss_frame_force_to_world(&frame, direct, world);
            ss_rotate(turned, q_world, unit);
            const double sign = axis == 0 && frame.is_mirror ? -1.0 : 1.0;
            for (int k = 0; k < 3; ++k) {
                assert_near(turned[k], sign * world[k], 1e-14);
            }
        }
        /* Power is kept up to the scales: f_device . v_device = force_scale / scale f . v */
        ss_frame_velocity(&frame, at, world);
        ss_frame_force_to_device(&frame, force, device_force);
        assert_near(ss_dot3(device_force, at), 0.5 / 2.0 * ss_dot3(force, world), 1e-15);
    }
}

/* ---- corrector
 * ------------------------------------------------------------------------------------ */

static softsim_force make_force(int32_t pose_seq)
{
    return (softsim_force){.seq = 40 + pose_seq,
                           .pose_seq = pose_seq,
                           .flags = SOFTSIM_FORCE_CONTACT,
                           .force = {0.25, 0.0, 1.0},
                           .normal = {0.0, 0.0, 1.0},
                           .stiffness = 500.0};
}

static void correction_follows_the_normal(void **state)
{
    (void)state;
    static ss_corrector c;
    const double at[3] = {0.01, 0.02, -0.002};
    double force[3];
    ss_corrector_init(&c, true);
    ss_corrector_force(&c, 0, at, force);
    assert_true(force[0] == 0.0 && force[2] == 0.0 && ss_corrector_force_seq(&c, 0) == -1);
    ss_corrector_note_pose(&c, 1, 1000000, at);
    const softsim_force given = make_force(1);
    ss_corrector_take_force(&c, &given, 3000000);
    assert_int_equal(ss_corrector_force_seq(&c, 3000000), 41);
    const double deeper[3] = {0.013, 0.02, -0.003};
    ss_corrector_force(&c, 3000000, deeper, force);
    assert_near(force[0], 0.25, 0.0); /* tangential part as it was */
    assert_near(force[2], 1.5, 1e-12);
    const double out[3] = {0.01, 0.02, 0.0015};
    ss_corrector_force(&c, 3000000, out, force);
    assert_near(force[2], 0.0, 0.0); /* never pulls in */
}

static void correction_is_bounded(void **state)
{
    (void)state;
    static ss_corrector c;
    static const struct {
        const char *what;
        bool is_enabled;
        double stiffness, normal_z, force_z, moved;
        int32_t pose_seq;
        int64_t now_ns;
        double expected;
    } cases[] = {
        {"corrected", true, 500, 1, 1, -1e-3, 5, 10000000, 1.5},
        {"off", false, 500, 1, 1, -1e-3, 5, 10000000, 1.0},
        {"stiffness 0", true, 0, 1, 1, -1e-3, 5, 10000000, 1.0},
        {"stiffness negative", true, -500, 1, 1, -1e-3, 5, 10000000, 1.0},
        {"stiffness beyond any coupling", true, 1e9, 1, 1, -1e-3, 5, 10000000, 21.0},
        {"moved 5.1 mm", true, 500, 1, 1, -5.1e-3, 5, 10000000, 1.0},
        {"moved 4.9 mm", true, 500, 1, 1, -4.9e-3, 5, 10000000, 3.45},
        {"pulling force", true, 500, 1, -1, -1e-3, 5, 10000000, -1.0},
        {"no unit normal", true, 500, 0.9, 1, -1e-3, 5, 10000000, 1.0},
        {"normal zero", true, 500, 0, 1, -1e-3, 5, 10000000, 1.0},
        {"pose 49 ms old", true, 500, 1, 1, -1e-3, 5, 49000000, 1.5},
        {"pose 51 ms old", true, 500, 1, 1, -1e-3, 5, 51000000, 1.0},
        {"pose unknown", true, 500, 1, 1, -1e-3, 6, 10000000, 1.0},
        {"pose negative", true, 500, 1, 1, -1e-3, -3, 10000000, 1.0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double at[3] = {0.0, 0.0, 0.0};
        const double now_at[3] = {0.0, 0.0, cases[i].moved};
        double out[3];
        softsim_force force = make_force(cases[i].pose_seq);
        force.stiffness = cases[i].stiffness;
        force.normal[2] = cases[i].normal_z;
        force.force[2] = cases[i].force_z;
        ss_corrector_init(&c, cases[i].is_enabled);
        ss_corrector_note_pose(&c, 5, 0, at);
        ss_corrector_take_force(&c, &force, cases[i].now_ns);
        ss_corrector_force(&c, cases[i].now_ns, now_at, out);
        if (!(fabs(out[2] - cases[i].expected) < 1e-9) || out[0] != 0.25) {
            fail_msg("%s: %.12g, not %g", cases[i].what, out[2], cases[i].expected);
        }
    }
}

static void force_fades_when_the_server_is_gone(void **state)
{
    (void)state;
    static ss_corrector c;
    const double at[3] = {0.0, 0.0, 0.0};
    double out[3];
    const softsim_force force = make_force(1);
    ss_corrector_init(&c, true);
    ss_corrector_take_force(&c, &force, 1000000000);
    double last = 1.0;
    for (int ms = 0; ms <= 100; ++ms) {
        ss_corrector_force(&c, 1000000000 + ms * 1000000LL, at, out);
        assert_near(out[2], ms <= 50 ? 1.0 : fmax(0.0, 1.0 - (ms - 50) / 20.0), 1e-12);
        assert_true(out[2] <= last);
        last = out[2];
    }
    assert_int_equal(ss_corrector_force_seq(&c, 1100000000), -1);
}

/* ---- bus
 * -------------------------------------------------------------------------------------------- */

static void bus_delays_and_keeps_order(void **state)
{
    (void)state;
    const ss_bus_config config = {.delay_ms = 2.0, .jitter_ms = 1.0, .outlier = 0.05, .seed = 3};
    ss_bus *bus = ss_bus_create(&config, sizeof(int));
    double sum_ms = 0.0;
    int next = 0;
    enum { COUNT = 20000 };
    for (int i = 0; i < COUNT; ++i) {
        const int64_t now_ns = i * 100000000LL; /* far apart: no queueing */
        int got = -1;
        assert_true(ss_bus_send(bus, now_ns, &i));
        const int64_t due_ns = ss_bus_due(bus);
        assert_true(due_ns >= now_ns + 2000000);
        assert_false(ss_bus_receive(bus, due_ns - 1, &got));
        assert_true(ss_bus_receive(bus, due_ns, &got));
        assert_int_equal(got, i);
        sum_ms += 1e-6 * (double)(due_ns - now_ns);
    }
    /* 2 + 1 + 0.05 x 12.5 ms, three standard errors */
    assert_near(sum_ms / COUNT, 3.625, 3.0 * 3.1 / sqrt(COUNT));
    for (int i = 0; i < 1000; ++i) {
        ss_bus_send(bus, COUNT * 100000000LL + i * 1000000LL, &i);
    }
    int got;
    while (ss_bus_receive(bus, INT64_MAX - 1, &got)) {
        assert_int_equal(got, next++);
    }
    assert_int_equal(next, 1000);
    assert_true(ss_bus_due(bus) == INT64_MAX);
    ss_bus_destroy(&bus);
}

static void bus_loses_its_share_and_is_bounded(void **state)
{
    (void)state;
    const ss_bus_config lossy = {.loss = 0.1, .seed = 9};
    ss_bus *bus = ss_bus_create(&lossy, sizeof(int));
    int lost = 0;
    for (int i = 0; i < 10000; ++i) {
        int got;
        lost += !ss_bus_send(bus, i, &i);
        while (ss_bus_receive(bus, i, &got)) {
        }
    }
    assert_in_range(lost, 900, 1100);
    int kept = 0;
    for (int i = 0; i < 10000; ++i) {
        kept += ss_bus_send(bus, 0, &i);
    }
    assert_in_range(kept, 1000, 4096);
    ss_bus_destroy(&bus);
}

/* ---- simulated device
 * ----------------------------------------------------------------------------- */

/* Runs the bridge against a linear tissue of 500 N/m, two ticks late; rows of its CSV. */
static int run_linear(bool is_correcting, double row[][14])
{
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_sim_config sim = {SS_BODY_MEDIUM, SS_GRIP_MEDIUM, SS_SCRIPT_PRESS, 1, 1e-3};
    ss_frame frame;
    ss_device device;
    static ss_bridge bridge;
    const char *path = in_folder("linear.csv");
    FILE *csv = fopen(path, "w");
    assert_non_null(csv);
    fputs(ss_bridge_csv_header, csv);
    assert_int_equal(ss_frame_init(&frame, "x,y,z", "0,0,0", 1.0, 1.0, &error), SOFTSIM_OK);
    assert_int_equal(ss_sim_create(&sim, &device, &error), SOFTSIM_OK);
    const ss_bridge_config config = {
        .is_correcting = is_correcting, .tick_count = 2000, .csv = csv};
    assert_int_equal(ss_bridge_init(&bridge, &config, &frame, &device, &error), SOFTSIM_OK);
    ss_bridge_run_linear(&bridge, 500.0, 2);
    ss_bridge_fini(&bridge);
    fclose(csv);
    csv = fopen(path, "r");
    char line[1024];
    int count = 0;
    assert_non_null(fgets(line, sizeof line, csv));
    assert_string_equal(line, "tick,x,y,z,vx,vy,vz,qx,qy,qz,fx,fy,fz,energy_in_j\n");
    while (count < 2001 && fgets(line, sizeof line, csv) != NULL) {
        char *at = line;
        for (int k = 0; k < 14; ++k) {
            row[count][k] = strtod(at, &at);
            at += *at == ',';
        }
        assert_true(*at == '\n' && row[count][0] == count);
        ++count;
    }
    fclose(csv);
    return count;
}

static void device_meets_the_golden_trajectories(void **state)
{
    (void)state;
    static const struct {
        bool is_correcting;
        int tick;
        double x, z, vz, fz, energy;
    } golden[] = {
        {false, 300, -8.813059081703534e-06, -1.4828397588406855e-03, -3.9615459047971466e-02,
         0.705, 4.753826449699047e-04},
        {false, 1000, 1.5864715315802944e-02, -2.997519045195684e-03, 3.297218465205668e-03, 1.5,
         2.0919013240455002e-03},
        {false, 1999, 1.9992377072798228e-02, 3.928322825046947e-03, 0.0, 0.0,
         -2.2328857728669052e-04},
        {true, 300, -8.808310299857372e-06, -1.4386691849223269e-03, -3.6887155254844660e-02, 0.72,
         5.174379595193946e-04},
        {true, 1000, 1.5864624333161374e-02, -2.995985449975701e-03, 2.894656372095478e-03, 1.5,
         2.204328552012963e-03},
        {true, 1999, 1.9991786382453358e-02, 3.9271984111761945e-03, 0.0, 0.0,
         -4.900114954307547e-05},
    };
    static double row[2001][14];
    for (int i = 0; i < 6; ++i) {
        assert_int_equal(run_linear(golden[i].is_correcting, row), 2000);
        const double *r = row[golden[i].tick];
        assert_near(r[1], golden[i].x, 1e-9);
        assert_near(r[3], golden[i].z, 1e-9);
        assert_near(r[6], golden[i].vz, 1e-9);
        assert_near(r[12], golden[i].fz, 1e-9);
        assert_near(r[13], golden[i].energy, 1e-9);
    }
}

static void free_device_follows_the_hand(void **state)
{
    (void)state;
    /* Every body, grip and script: at rest after the script the hand's friction and tremor leave
     * at most a millimetre, and no energy is exchanged without force. */
    for (int i = 0; i < 3 * 3 * 5; ++i) {
        softsim_error error = {.status = SOFTSIM_OK};
        const ss_sim_config config = {(ss_sim_body)(i % 3), (ss_sim_grip)(i / 3 % 3),
                                      (ss_sim_script)(i / 9), 1, 1e-3};
        ss_device device;
        ss_device_sample sample;
        const double none[3] = {0.0, 0.0, 0.0};
        bool was_grasped = false;
        assert_int_equal(ss_sim_create(&config, &device, &error), SOFTSIM_OK);
        for (int n = 0; n < 3000; ++n) {
            assert_true(device.read(device.state, &sample));
            assert_true(ss_norm3(sample.true_position) < 0.1);
            for (int k = 0; k < 3; ++k) {
                assert_near(sample.position[k], sample.true_position[k], 15.001e-6);
                assert_near(sample.position[k] / 30e-6, round(sample.position[k] / 30e-6), 1e-9);
            }
            was_grasped = was_grasped || sample.buttons == SOFTSIM_BUTTON_GRASP;
            device.exert(device.state, none);
        }
        assert_int_equal(was_grasped, config.script == SS_SCRIPT_GRASP);
        if (config.script == SS_SCRIPT_PRESS || config.script == SS_SCRIPT_GRASP) {
            device.read(device.state, &sample);
            assert_near(sample.true_position[2], config.script == SS_SCRIPT_PRESS ? 0.004 : 0.010,
                        1.2e-3);
        }
        device.destroy(device.state);
    }
}

static void script_device_follows_its_path(void **state)
{
    (void)state;
    static const char text[] = CSV_HEADER "2,3,0,0,0,1,0,0,0,0\n2.1,3,0.1,0,0,1,0,0,0,1\n";
    softsim_error error = {.status = SOFTSIM_OK};
    ss_device device;
    ss_device_sample sample;
    const double pushed[3] = {5.0, 0.0, 0.0};
    write_file(in_folder("path.csv"), text, strlen(text));
    assert_int_equal(ss_script_create(in_folder("path.csv"), 1e-3, &device, &error), SOFTSIM_OK);
    int count = 0;
    while (device.read(device.state, &sample)) {
        assert_near(sample.position[0], 1e-3 * count, 1e-12);
        device.exert(device.state, pushed);
        ++count;
    }
    assert_int_equal(count, 101);
    assert_int_equal(sample.buttons, 1);
    device.destroy(device.state);
    assert_int_equal(ss_script_create(in_folder("none.csv"), 1e-3, &device, &error),
                     SOFTSIM_ERROR_FILE);
}

/* ---- monitor
 * ----------------------------------------------------------------------------------------- */

static void json_is_well_formed(void **state)
{
    (void)state;
    static char scene[] = "a \"quoted\" \\ \n \x01 name";
    static char model[] = "fem";
    static char reason[] = "";
    softsim_server_status_t status = {.scene = scene, .model = model, .reason = reason};
    status.step = INT64_MIN;
    status.uptime_s = 1.5;
    status.stable_step_s = INFINITY;
    status.step_us[1] = NAN;
    status.poses_refused[7] = 3;
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    ss_show_json(out, &status);
    ss_show_line(out, &status);
    ss_show_page(out, &status);
    fclose(out);
    assert_non_null(strstr(text, "\"scene\": \"a \\\"quoted\\\" \\\\ \\u000a \\u0001 name\""));
    assert_non_null(strstr(text, "\"step\": -9223372036854775808"));
    assert_non_null(strstr(text, "\"uptime_s\": 1.5,"));
    assert_non_null(strstr(text, "\"stable_step_s\": null"));
    assert_non_null(strstr(text, "\"step_us\": [0, null, 0]"));
    assert_non_null(strstr(text, "\"poses_refused\": [0, 0, 0, 0, 0, 0, 0, 3]"));
    assert_non_null(strstr(text, "\"reason\": \"\"}\n"));
    assert_null(strchr(text, '\x01')); /* nor in the text for people */
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(log_gives_back_what_was_written),
        cmocka_unit_test(log_format_is_lcms),
        cmocka_unit_test(every_truncation_is_reported),
        cmocka_unit_test(damage_costs_one_record),
        cmocka_unit_test(a_length_too_short_keeps_the_others),
        cmocka_unit_test(any_bytes_are_survived),
        cmocka_unit_test(a_log_of_fake_headers_is_read_in_linear_time),
        cmocka_unit_test(large_payloads_are_passed_over),
        cmocka_unit_test(probe_channels_have_any_prefix),
        cmocka_unit_test(only_exact_messages_are_decoded),
        cmocka_unit_test(output_is_complete_or_absent),
        cmocka_unit_test(csv_faults_name_their_line),
        cmocka_unit_test(csv_names_all_its_faults),
        cmocka_unit_test(path_is_interpolated),
        cmocka_unit_test(quaternions_take_the_short_way),
        cmocka_unit_test(csv_is_sampled_on_the_ticks),
        cmocka_unit_test(log_poses_keep_their_times),
        cmocka_unit_test(restamped_poses_are_a_new_senders),
        cmocka_unit_test(axes_are_signed_permutations),
        cmocka_unit_test(frames_are_consistent),
        cmocka_unit_test(correction_follows_the_normal),
        cmocka_unit_test(correction_is_bounded),
        cmocka_unit_test(force_fades_when_the_server_is_gone),
        cmocka_unit_test(bus_delays_and_keeps_order),
        cmocka_unit_test(bus_loses_its_share_and_is_bounded),
        cmocka_unit_test(device_meets_the_golden_trajectories),
        cmocka_unit_test(free_device_follows_the_hand),
        cmocka_unit_test(script_device_follows_its_path),
        cmocka_unit_test(json_is_well_formed),
    };
    return cmocka_run_group_tests_name("clients", tests, make_folder, remove_folder);
}
