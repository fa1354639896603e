/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* Clients without a network: event logs, pose paths, poses of either, output files. */
#include "common/test.h"

#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/folder_fixture.h"
#include "common/log_fixture.h"
#include "common/number_fixture.h"
#include "indentation.h"
#include "net/codec.h"
#include "output.h"
#include "rt/files.h"
#include "rt/random.h"
#include "softsim/log.h"

static size_t read_file(const char *path, unsigned char *data, size_t capacity)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(data, 1, capacity, file);
    fclose(file);
    return size;
}

/* ---- event logs ---- */

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

TEST(log_gives_back_what_was_written)
{
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

TEST(log_format_is_lcms)
{
    unsigned char data[LOG_SIZE];
    make_log(in_folder("good.lcmlog"), data);
    static const unsigned char head[28] = {
        0xED, 0xA1, 0xDA, 0x01, 0,    0,    0, 0, 0, 0,  0, 0, 0, 0,
        0,    0,    0,    0x0F, 0x42, 0x40, 0, 0, 0, 15, 0, 0, 0, SS_WIRE_POSE_SIZE};
    assert_memory_equal(data, head, sizeof head);
}

TEST(every_truncation_is_reported)
{
    unsigned char data[LOG_SIZE];
    const char *path = in_folder("cut.lcmlog");
    make_log(path, data);
    for (size_t size = 0; size <= 3 * RECORD; ++size) {
        write_bytes("cut.lcmlog", data, size);
        const tally found = read_log(path);
        assert_int_equal(found.events, size / RECORD);
        assert_int_equal(found.truncated, size % RECORD != 0);
        assert_int_equal(found.damaged, 0);
        assert_int_equal(found.skipped, size % RECORD);
    }
}

TEST(damage_costs_one_record)
{
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
            write_bytes("bad.lcmlog", data, LOG_SIZE);
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

TEST(a_length_too_short_keeps_the_others)
{
    unsigned char data[LOG_SIZE];
    const char *path = in_folder("short.lcmlog");
    make_log(path, data);
    put32(data + 5 * RECORD + 24, 100);
    write_bytes("short.lcmlog", data, LOG_SIZE);
    const tally found = read_log(path);
    assert_int_equal(found.events, POSES); /* one of them too short to be a pose */
    assert_int_equal(found.skipped, SS_WIRE_POSE_SIZE - 100);
}

TEST(any_bytes_are_survived)
{
    uint64_t random = 12345;
    for (int round = 0; round < 400; ++round) {
        unsigned char data[LOG_SIZE];
        const char *path = in_folder("fuzz.lcmlog");
        make_log(path, data);
        for (int i = 0; i < 30; ++i) {
            data[ss_random_next(&random) % LOG_SIZE] = (unsigned char)ss_random_next(&random);
        }
        const size_t size = ss_random_next(&random) % (LOG_SIZE + 1);
        write_bytes("fuzz.lcmlog", data, size);
        const tally found = read_log(path);
        assert_int_equal(found.bytes, size);
    }
}

TEST(a_log_of_fake_headers_is_read_in_linear_time)
{
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
    const char *path = write_bytes("fake.lcmlog", data, (size_t)COUNT * SIZE);
    free(data);
    const tally found = read_log(path);
    assert_int_equal(found.bytes, (int64_t)COUNT * SIZE);
}

TEST(large_payloads_are_passed_over)
{
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

TEST(probe_channels_have_any_prefix)
{
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

TEST(only_exact_messages_are_decoded)
{
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

TEST(output_is_complete_or_absent)
{
    softsim_error error = {.status = SOFTSIM_OK};
    ss_output output;
    struct stat found;
    const char *path = in_folder("out.txt");
    assert_int_equal(ss_output_open(&output, path, &error), SOFTSIM_OK);
    fputs("half", output.file);
    assert_int_equal(access(path, F_OK), -1);
    ss_output_abandon(&output);
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(ss_output_open(&output, path, &error), SOFTSIM_OK);
    assert_int_equal(ss_output_commit(&output, &error), SOFTSIM_OK);
    assert_int_equal(access(path, F_OK), 0);
    assert_int_equal(ss_output_open(&output, path, &error), SOFTSIM_OK);
    assert_int_equal(ss_output_reserve(&output, 100000, &error), SOFTSIM_OK);
    fputs("less", output.file);
    assert_int_equal(ss_output_commit(&output, &error), SOFTSIM_OK);
    assert_int_equal(stat(path, &found), 0);
    assert_int_equal(found.st_size, 4); /* what was not needed is given back */
    assert_int_equal(ss_output_open(&output, in_folder("no/such"), &error), SOFTSIM_ERROR_FILE);
    assert_int_equal(ss_output_commit(&output, &error), SOFTSIM_OK); /* not open: nothing */
    const int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
    for (int count = 1; full >= 0 && count < 1000000; count *= 10) { /* by whichever write */
        error = (softsim_error){.status = SOFTSIM_OK};
        assert_int_equal(ss_output_open(&output, in_folder("full"), &error), SOFTSIM_OK);
        assert_true(dup2(full, output.descriptor) >= 0);
        for (int i = 0; i < count; ++i) {
            fputs("lost", output.file);
        }
        assert_int_equal(ss_output_commit(&output, &error), SOFTSIM_ERROR_FILE);
        assert_non_null(strstr(error.text, "full: cannot write: the disk is full: make room"));
        assert_int_equal(access(in_folder("full"), F_OK), -1);
    }
    close(full);
}

/* ---- pose paths ---- */

/* ---- recordings ---- */

static void write_poses(softsim_log_writer *writer, int count)
{
    for (int i = 0; i < count; ++i) {
        const softsim_pose pose = make_pose(i + 1);
        softsim_log_write_pose(writer, 1000000 + 1000 * i, "SOFTSIM_PROBE_0", &pose);
    }
}

/* What a kill would leave: the file as it is before the writer has done anything at its end. */
TEST(a_recording_is_readable_while_it_grows)
{
    enum { MANY = 8000 }; /* more than fits into memory that waits */
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    int64_t rest = 0;
    const char *path = in_folder("grows.lcmlog"), *part = in_folder("grows.lcmlog.part");
    assert_int_equal(softsim_log_create(path, &writer, &error), SOFTSIM_OK);
    assert_string_equal(softsim_log_path(writer), part);
    write_poses(writer, MANY);
    assert_in_range(count_records(part, &rest), 1000, MANY);
    assert_int_equal(rest, 0);
    assert_int_equal(access(path, F_OK), -1);

    /* Nobody else writes to it meanwhile. */
    softsim_log_writer *other = NULL;
    assert_int_equal(softsim_log_create(path, &other, &error), SOFTSIM_ERROR_FILE);
    assert_non_null(strstr(error.text, "grows.lcmlog.part: another program is recording to it"));
    error = (softsim_error){.status = SOFTSIM_OK};
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_OK);
    assert_int_equal(count_records(path, &rest), MANY);
    assert_int_equal(access(part, F_OK), -1);
}

/* RLIMIT_FSIZE stands for the disk. */
TEST(a_full_disk_leaves_whole_records)
{
    enum { MANY = 12000, ROOM = 700000 };
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    int64_t rest = 0;
    struct rlimit limit;
    struct stat found;
    const char *part = in_folder("full.lcmlog.part");
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    const struct rlimit small = {ROOM, limit.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    assert_int_equal(softsim_log_create(in_folder("full.lcmlog"), &writer, &error), SOFTSIM_OK);
    write_poses(writer, MANY);
    assert_true(softsim_log_has_failed(writer));
    assert_int_equal(softsim_log_finish(&writer, &error), SOFTSIM_ERROR_FILE);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    assert_non_null(
        strstr(error.text, "cannot write: File too large; what was recorded before is"));
    assert_non_null(strstr(error.text, part));
    assert_int_equal(access(in_folder("full.lcmlog"), F_OK), -1);
    assert_int_equal(stat(part, &found), 0);
    assert_true(found.st_size > ROOM / 2 && found.st_size <= ROOM);
    assert_int_equal(count_records(part, &rest), found.st_size / RECORD);
    assert_int_equal(rest, 0);
}

/* A press straight down by 10 mm against tissue that leaves 0.4 mm, a slide along a cylinder of
 * 50 mm, and lifting. */
TEST(indentation_is_the_tools_way_into_the_tissue)
{
    ss_indentation indentation = {.is_touching = false};
    double value = 0.0;
    for (int k = 0; k <= 200; ++k) {
        const double depth = 1e-4 * k - 0.01; /* of the tool; it touches at k = 100 */
        const double left = fmin(depth, 4e-4);
        const softsim_force force = {.flags = depth > 0.0 ? SOFTSIM_FORCE_CONTACT : 0,
                                     .normal = {0.0, 0.0, 1.0},
                                     .proxy = {0.0, 0.0, depth > 0.0 ? left - depth : -depth},
                                     .depth = left};
        const double tool[3] = {0.0, 0.0, -depth};
        value = ss_indentation_take(&indentation, &force, tool);
        assert_near(value, fmax(depth, 0.0), 1e-12);
    }
    for (int k = 1; k <= 900; ++k) {
        const double angle = 1e-3 * k, radius = 0.05 - 0.01;
        const softsim_force force = {
            .flags = SOFTSIM_FORCE_CONTACT, .normal = {sin(angle), 0.0, cos(angle)}, .depth = 4e-4};
        const double tool[3] = {radius * sin(angle), 0.0, radius * cos(angle) - 0.05};
        value = ss_indentation_take(&indentation, &force, tool);
    }
    assert_near(value, 0.01, 3e-5); /* straight 0.052 m down by now, were it not for the normal */
    const softsim_force unknown = {.flags = SOFTSIM_FORCE_CONTACT, .normal = {0.0, 0.0, 1.0}};
    const double nowhere[3] = {NAN, 0.0, 0.0};
    assert_near(ss_indentation_take(&indentation, &unknown, nowhere), value, 0.0);
    const softsim_force off = {.flags = 0};
    assert_true(ss_indentation_take(&indentation, &off, nowhere) == 0.0);
}

#define CSV_HEADER "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n"

TEST(csv_faults_name_their_line)
{
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
        write_text("bad.csv", text);
        assert_int_equal(softsim_path_load(in_folder("bad.csv"), &path, &error),
                         SOFTSIM_ERROR_FORMAT);
        assert_null(path);
        assert_int_equal(error.fault_count, 1);
        if (strstr(error.text, cases[i].fault) == NULL) {
            fail_msg("'%s' is not in: %s", cases[i].fault, error.text);
        }
    }
}

TEST(csv_names_all_its_faults)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_path *path = NULL;
    static const char text[] = CSV_HEADER "0,9,0,0,0,1,0,0,0,0\n1,0,0,0,0,1,0,0,0,0\nx\n";
    write_text("bad.csv", text);
    assert_int_equal(softsim_path_load(in_folder("bad.csv"), &path, &error), SOFTSIM_ERROR_FORMAT);
    assert_int_equal(error.fault_count, 2);
    assert_non_null(strstr(error.text, ":2: "));
    assert_non_null(strstr(error.text, ":4: "));
    static const char other[] = "t,x,y\n0,0,0\n";
    write_text("bad.csv", other);
    error = (softsim_error){.status = SOFTSIM_OK};
    assert_int_equal(softsim_path_load(in_folder("bad.csv"), &path, &error), SOFTSIM_ERROR_FORMAT);
    assert_non_null(strstr(error.text, ":1: "));
    error = (softsim_error){.status = SOFTSIM_OK};
    assert_int_equal(softsim_path_load(in_folder("none.csv"), &path, &error), SOFTSIM_ERROR_FILE);
}

TEST(path_is_interpolated)
{
    /* A quarter turn about z while moving along x; CRLF ends. */
    static const char text[] = "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\r\n"
                               "1,2,0,0,0.5,1,0,0,0,1\r\n"
                               "3,2,0.2,0,0.5,0.70710678118654752,0,0,0.70710678118654752,0\r\n";
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_path *path = NULL;
    softsim_pose pose;
    write_text("path.csv", text);
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

TEST(quaternions_take_the_short_way)
{
    /* q and -q are the same orientation: between them nothing turns. */
    static const char text[] = CSV_HEADER "0,0,0,0,0,0.6,0.8,0,0,0\n1,0,0,0,0,-0.6,-0.8,0,0,0\n";
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_path *path = NULL;
    softsim_pose pose;
    write_text("path.csv", text);
    assert_int_equal(softsim_path_load(in_folder("path.csv"), &path, &error), SOFTSIM_OK);
    assert_true(softsim_path_sample(path, 0, 0.5, &pose));
    assert_near(pose.orientation[0], 0.6, 1e-15);
    assert_near(pose.orientation[1], 0.8, 1e-15);
    softsim_path_free(&path);
}

/* Its columns by their names, in whatever order those behind the first fourteen are. */
TEST(what_a_bridge_writes_is_a_path)
{
#define BRIDGE "tick,x,y,z,vx,vy,vz,qx,qy,qz,fx,fy,fz,energy_in_j"
    static const struct {
        const char *text;
        int probe, buttons;
        double end_s, w;
    } good[] = {
        {BRIDGE "\n0,9,9,9,8,8,8,0.1,0.2,0.3,7,7,7,6\n4,9,9,9,8,8,8,0.5,0.2,0.3,7,7,7,6\n", 0, 0,
         0.004, 1.0},
        {BRIDGE ",time_s,probe,ow,ox,oy,oz,buttons,depth_m,indentation_m\n"
                "0,9,9,9,8,8,8,0.1,0.2,0.3,7,7,7,6,0,3,0.6,0.8,0,0,1,5,5\n"
                "4,9,9,9,8,8,8,0.5,0.2,0.3,7,7,7,6,0.002,3,0.6,0.8,0,0,1,5,5\n",
         3, 1, 0.002, 0.6},
    };
    for (int k = 0; k < 2; ++k) {
        softsim_error error = {.status = SOFTSIM_OK};
        softsim_path *path = NULL;
        softsim_pose pose;
        double begin_s = 1.0, end_s = 0.0;
        write_text("bridge.csv", good[k].text);
        if (softsim_path_load(in_folder("bridge.csv"), &path, &error) != SOFTSIM_OK) {
            fail_msg("%s", error.text);
        }
        assert_int_equal(softsim_path_probes(path), 1 << good[k].probe);
        softsim_path_range(path, -1, &begin_s, &end_s);
        assert_near(begin_s, 0.0, 0.0);
        assert_near(end_s, good[k].end_s, 1e-15);
        assert_true(softsim_path_sample(path, good[k].probe, 0.5 * end_s, &pose));
        assert_near(pose.position[0], 0.3, 1e-15); /* as sent, not as it was */
        assert_near(pose.position[2], 0.3, 1e-15);
        assert_near(pose.orientation[0], good[k].w, 1e-15);
        assert_int_equal(pose.buttons, good[k].buttons);
        softsim_path_free(&path);
    }
    static const char *const bad[] = {BRIDGE "s\n0,9,9,9,8,8,8,1,2,3,7,7,7,6\n",
                                      BRIDGE "\n0,9,9,9,8,8,8,1,2,3,7,7,7\n",
                                      BRIDGE "\n0,9,9,9,8,8,8,1,2,nan,7,7,7,6\n"};
    static const char *const said[] = {":1: not a pose path", ":2: 13 columns", ":2: column 10"};
    for (int k = 0; k < 3; ++k) {
        softsim_error error = {.status = SOFTSIM_OK};
        softsim_path *path = NULL;
        write_text("bridge.csv", bad[k]);
        assert_int_equal(softsim_path_load(in_folder("bridge.csv"), &path, &error),
                         SOFTSIM_ERROR_FORMAT);
        assert_non_null(strstr(error.text, said[k]));
    }
}

/* A kill in the middle of a write cuts the file at any byte: half a row is left out, and said once
 * a pass. A row without its last digits would be taken for a whole one. */
TEST(half_a_row_at_the_end_is_left_out)
{
    static const char row[] = "2,9,9,9,8,8,8,0.5,0.2,0.3,7,7,7,6.25\n";
    for (size_t cut = 1; cut < sizeof row - 1; ++cut) {
        char text[256], note[80];
        softsim_error error = {.status = SOFTSIM_OK};
        softsim_poses *poses = NULL;
        softsim_pose_event event;
        snprintf(text, sizeof text,
                 BRIDGE "\n0,9,9,9,8,8,8,0.1,0,0,7,7,7,6\n1,9,9,9,8,8,8,0.2,0,0,7,7,7,6\n%.*s",
                 (int)cut, row);
        write_text("bridge.csv", text);
        assert_int_equal(softsim_poses_open(in_folder("bridge.csv"), 1000.0, &poses, &error),
                         SOFTSIM_OK);
        for (int pass = 0; pass < 2; ++pass) {
            for (int k = 0; k < 2; ++k) {
                assert_int_equal(softsim_poses_next(poses, &event, note, sizeof note),
                                 SOFTSIM_POSES_POSE);
            }
            assert_int_equal(softsim_poses_next(poses, &event, note, sizeof note),
                             SOFTSIM_POSES_NOTE);
            assert_non_null(strstr(note, "line 4 is half a row"));
            assert_int_equal(softsim_poses_next(poses, &event, note, sizeof note),
                             SOFTSIM_POSES_END);
            softsim_poses_rewind(poses);
        }
        softsim_poses_close(&poses);
    }
}

/* ---- poses of either ---- */

TEST(csv_is_sampled_on_the_ticks)
{
    static const char text[] = CSV_HEADER "0.0101,0,0,0,0,1,0,0,0,0\n0.2,0,1,0,0,1,0,0,0,0\n"
                                          "0.1,5,0,0,0,1,0,0,0,0\n0.2,5,0,0,0,1,0,0,0,0\n";
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_poses *poses = NULL;
    softsim_pose_event event;
    char note[64];
    write_text("path.csv", text);
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

TEST(log_poses_keep_their_times)
{
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    softsim_poses *poses = NULL;
    const char *path = in_folder("times.lcmlog");
    static const struct {
        int64_t utime_us;
        int64_t time_us; /* expected */
        bool is_noted;
    } cases[] = {{205000, 0, false},      {206000, 1000, false},
                 {205500, 1000, false}, /* two senders' poses crossed: no time lost or gained */
                 {207000, 2000, false},   {106999, 2000, true},
                 {107999, 3000, false},   {90000000, 3000, true},
                 {90001000, 4000, false}, {INT64_MIN, 4000, true},
                 {INT64_MAX, 4000, true}, {INT64_MAX, 4000, false}};
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

TEST(restamped_poses_are_a_new_senders)
{
    softsim_pose pose = make_pose(17);
    pose.velocity[1] = 0.25;
    softsim_poses_restamp(&pose, 99, 1);
    assert_true(pose.sender == 99 && pose.seq == 1 && pose.force_seq == -1 && pose.flags == 0);
    assert_true(isnan(pose.applied_force[0]) && isnan(pose.applied_force[2]));
    assert_true(pose.velocity[1] == 0.25 && pose.buttons == 1 && pose.position[0] == 0.017);
}

/* What stands behind a name of the shell's own is written, and the name stays: renaming over it
 * would put a file in its place. A pipe of another name, which would wait for its reader, is
 * refused and stays too. */
TEST(a_pipe_of_the_shell_is_written_another_refused)
{
    char path[160], own[32], read_back[16] = "";
    int end[2];
    softsim_error error = {0};
    ss_output output;
    assert_int_equal(pipe(end), 0);
    snprintf(own, sizeof own, "/dev/fd/%d", end[1]);
    assert_int_equal(ss_output_open(&output, own, &error), SOFTSIM_OK);
    assert_true(fputs("force", output.file) >= 0);
    assert_int_equal(ss_output_commit(&output, &error), SOFTSIM_OK);
    assert_int_equal(read(end[0], read_back, sizeof read_back - 1), 5);
    assert_string_equal(read_back, "force");
    close(end[0]);
    close(end[1]);

    snprintf(path, sizeof path, "%s", in_folder("pipe"));
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(ss_output_open(&output, path, &error), SOFTSIM_ERROR_FILE);
    assert_int_equal(ss_output_record(&output, path, &error), SOFTSIM_ERROR_FILE);
    assert_int_equal(ss_output_record(&output, folder, &error), SOFTSIM_ERROR_FILE);
    assert_non_null(strstr(error.text, "pipe: a pipe, not a file"));
    assert_non_null(strstr(error.text, "a folder, not a file"));
    struct stat found;
    assert_int_equal(stat(path, &found), 0);
    assert_true(S_ISFIFO(found.st_mode));
}

/* The same command again, before anyone has looked: what a killed program left is kept, each time,
 * and what is given up meanwhile takes its own alone along. */
TEST(what_a_killed_program_left_is_kept)
{
    char path[512], kept[600], line[32];
    snprintf(path, sizeof path, "%s", in_folder("again.csv"));
    for (int run = 0; run < 3; ++run) {
        softsim_error error = {.status = SOFTSIM_OK};
        ss_output output;
        assert_int_equal(ss_output_record(&output, path, &error), SOFTSIM_OK);
        if (run == 0) {
            assert_null(output.kept);
        } else {
            snprintf(kept, sizeof kept, "%s.%d.part", path, run);
            assert_string_equal(output.kept, kept);
            FILE *file = fopen(kept, "r");
            assert_non_null(file);
            assert_non_null(fgets(line, sizeof line, file));
            assert_int_equal(atoi(line), run - 1);
            fclose(file);
        }
        if (run == 2) {
            ss_output_abandon(&output);
        } else {
            fprintf(output.file, "%d\n", run);
            ss_output_keep(&output, &error); /* as far as a kill lets it come */
        }
    }
    snprintf(kept, sizeof kept, "%s.part", path);
    assert_int_equal(access(kept, F_OK), -1);
}

TEST(an_output_has_a_name)
{
    const ss_named_file unnamed = {"--csv", ""};
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_log_writer *writer = NULL;
    assert_false(ss_files_check(NULL, 0, &unnamed, 1, &error));
    assert_non_null(strstr(error.text, "the name is empty"));
    assert_int_equal(softsim_log_create("", &writer, &error), SOFTSIM_ERROR_FILE);
    assert_null(writer);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
