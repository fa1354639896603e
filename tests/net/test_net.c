/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * net/wire and net/net: nothing malformed is ever decoded; forces, status, commands and replies
 * cross LCM (memq://, in one process) unchanged.
 */
#include "common/test.h"

#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "net/net.h"
#include "net/wire.h"
#include "softsim_command_t.h"
#include "softsim_contact_force_t.h"
#include "softsim_probe_pose_t.h"
#include "softsim_reply_t.h"
#include "softsim_server_status_t.h"

static const double UNKNOWN = (double)NAN;

/* ---- decoding ---- */

enum { MESSAGE_SIZE = 4096 };

static int encode_pose(uint8_t *out_message)
{
    const softsim_probe_pose_t wire = {.utime = 123456789,
                                       .sender = -77,
                                       .seq = 42,
                                       .probe = 3,
                                       .buttons = 1,
                                       .force_seq = -1,
                                       .flags = 1,
                                       .position = {0.25, -0.5, 0.125},
                                       .orientation = {0.5, 0.5, -0.5, 0.5},
                                       .velocity = {1, 2, 3},
                                       .applied_force = {UNKNOWN, UNKNOWN, UNKNOWN}};
    return softsim_probe_pose_t_encode(out_message, 0, MESSAGE_SIZE, &wire);
}

static int encode_command(uint8_t *out_message, const char *name, const char *argument)
{
    const softsim_command_t wire = {.utime = 9,
                                    .sender = 8,
                                    .seq = 7,
                                    .id = 6,
                                    .name = (char *)name,
                                    .argument = (char *)argument};
    return softsim_command_t_encode(out_message, 0, MESSAGE_SIZE, &wire);
}

/* A copy of exactly `size` bytes, so that a sanitizer sees one byte too many read. */
static void *exact_copy(const uint8_t *message, int size)
{
    uint8_t *copy = malloc(size > 0 ? (size_t)size : 1);
    memcpy(copy, message, size > 0 ? (size_t)size : 0);
    return copy;
}

static softsim_refusal decode_pose_of(const uint8_t *message, int size)
{
    softsim_pose pose;
    void *copy = exact_copy(message, size);
    const softsim_refusal refusal = ss_net_decode_pose(copy, size, 5, &pose);
    free(copy);
    return refusal;
}

static softsim_refusal decode_command_of(const uint8_t *message, int size)
{
    ss_net_command command;
    void *copy = exact_copy(message, size);
    const softsim_refusal refusal = ss_net_decode_command(copy, size, &command);
    free(copy);
    return refusal;
}

TEST(a_pose_is_decoded_as_it_was_sent)
{
    uint8_t message[MESSAGE_SIZE];
    const int size = encode_pose(message);
    softsim_pose pose;
    assert_int_equal(ss_net_decode_pose(message, size, 5, &pose), SOFTSIM_ACCEPTED);
    assert_int_equal(pose.utime_us, 123456789);
    assert_int_equal(pose.sender, -77);
    assert_int_equal(pose.receive_ns, 5);
    assert_int_equal(pose.seq, 42);
    assert_int_equal(pose.probe, 3);
    assert_int_equal(pose.buttons, 1);
    assert_int_equal(pose.force_seq, -1);
    assert_int_equal(pose.flags, 1);
    assert_true(pose.position[0] == 0.25 && pose.position[1] == -0.5 && pose.position[2] == 0.125);
    assert_true(pose.orientation[0] == 0.5 && pose.orientation[2] == -0.5);
    assert_true(pose.velocity[0] == 1 && pose.velocity[2] == 3);
    assert_true(isnan(pose.applied_force[0]) && isnan(pose.applied_force[2]));
}

TEST(only_the_whole_message_is_decoded)
{
    uint8_t message[MESSAGE_SIZE] = {0};
    int size = encode_pose(message);
    for (int n = 0; n <= size + 9; ++n) {
        assert_int_equal(decode_pose_of(message, n),
                         n == size ? SOFTSIM_ACCEPTED : SOFTSIM_REFUSED_MALFORMED);
    }
    memset(message, 0, sizeof message);
    size = encode_command(message, "set", "haptic.max_force_n=3");
    for (int n = 0; n <= size + 9; ++n) {
        assert_int_equal(decode_command_of(message, n),
                         n == size ? SOFTSIM_ACCEPTED : SOFTSIM_REFUSED_MALFORMED);
    }
}

TEST(another_type_is_told_by_its_hash)
{
    uint8_t message[MESSAGE_SIZE];
    const int pose_size = encode_pose(message);
    assert_int_equal(decode_command_of(message, pose_size), SOFTSIM_REFUSED_TYPE_HASH);
    for (int bit = 0; bit < 64; ++bit) {
        message[bit / 8] ^= (uint8_t)(1 << bit % 8);
        assert_int_equal(decode_pose_of(message, pose_size), SOFTSIM_REFUSED_TYPE_HASH);
        message[bit / 8] ^= (uint8_t)(1 << bit % 8);
    }
    const int size = encode_command(message, "reset", "");
    for (int bit = 0; bit < 64; ++bit) {
        message[bit / 8] ^= (uint8_t)(1 << bit % 8);
        assert_int_equal(decode_command_of(message, size), SOFTSIM_REFUSED_TYPE_HASH);
        message[bit / 8] ^= (uint8_t)(1 << bit % 8);
    }
}

TEST(hostile_string_lengths_are_malformed)
{
    const uint32_t hostile[] = {0,          1,          2,          5,          7,
                                33,         1025,       65536,      0x40000001, 0x7ffffffe,
                                0x7fffffff, 0x80000000, 0xfffffffe, 0xffffffff};
    uint8_t message[MESSAGE_SIZE];
    const int size = encode_command(message, "reset", "abc");
    const int at[] = {8 + 8 + 8 + 4 + 4, 8 + 8 + 8 + 4 + 4 + 4 + 6};
    for (size_t h = 0; h < sizeof hostile / sizeof hostile[0]; ++h) {
        for (int s = 0; s < 2; ++s) {
            uint8_t spoiled[MESSAGE_SIZE];
            memcpy(spoiled, message, sizeof spoiled);
            for (int b = 0; b < 4; ++b) {
                spoiled[at[s] + b] = (uint8_t)(hostile[h] >> (24 - 8 * b));
            }
            assert_int_equal(decode_command_of(spoiled, size), SOFTSIM_REFUSED_MALFORMED);
        }
    }
}

TEST(strings_are_bounded_and_clean)
{
    static char name[64];
    static char argument[2048];
    uint8_t message[MESSAGE_SIZE];
    for (int length = 0; length < 40; ++length) {
        memset(name, 'n', sizeof name);
        name[length] = '\0';
        const int size = encode_command(message, name, "");
        assert_int_equal(decode_command_of(message, size),
                         length < 32 ? SOFTSIM_ACCEPTED : SOFTSIM_REFUSED_MALFORMED);
    }
    for (int length = 1020; length < 1030; ++length) {
        memset(argument, 'a', sizeof argument);
        argument[length] = '\0';
        const int size = encode_command(message, "set", argument);
        assert_int_equal(decode_command_of(message, size),
                         length < 1024 ? SOFTSIM_ACCEPTED : SOFTSIM_REFUSED_MALFORMED);
    }
    /* Control characters would end up on somebody's terminal; UTF-8 is welcome. */
    assert_int_equal(decode_command_of(message, encode_command(message, "set", "a\033[2J")),
                     SOFTSIM_REFUSED_MALFORMED);
    assert_int_equal(decode_command_of(message, encode_command(message, "set", "a\nb")),
                     SOFTSIM_REFUSED_MALFORMED);
    assert_int_equal(decode_command_of(message, encode_command(message, "set", "a\177b")),
                     SOFTSIM_REFUSED_MALFORMED);
    assert_int_equal(decode_command_of(message, encode_command(message, "set", "Leber\xc3\xa4=1")),
                     SOFTSIM_ACCEPTED);
    /* A NUL inside, and none at the end. */
    int size = encode_command(message, "reset", "abc");
    message[size - 2] = 0;
    assert_int_equal(decode_command_of(message, size), SOFTSIM_REFUSED_MALFORMED);
    size = encode_command(message, "reset", "abc");
    message[size - 1] = 'd';
    assert_int_equal(decode_command_of(message, size), SOFTSIM_REFUSED_MALFORMED);
}

/* ---- the wire ---- */

typedef struct heard {
    int signal_fd; /* > 0: signalled by every pose */
    int poses, commands, refusals[SOFTSIM_REFUSED_COUNT], last_channel;
    softsim_pose pose;
    int64_t receive_ns;
    char name[32], argument[1024];
    /* Messages that went out. */
    int messages;
    char channel[64];
    uint8_t data[70000];
    int size;
} heard;

static void hear_pose(void *context, const softsim_pose *pose, int32_t channel_probe,
                      int64_t receive_ns)
{
    heard *h = context;
    h->poses += 1;
    h->pose = *pose;
    h->last_channel = channel_probe;
    h->receive_ns = receive_ns;
    if (h->signal_fd > 0) {
        ss_wake_signal(h->signal_fd);
    }
}

static void hear_refusal(void *context, softsim_refusal reason, int32_t channel_probe)
{
    heard *h = context;
    h->refusals[reason] += 1;
    h->last_channel = channel_probe;
}

static int32_t hear_command(void *context, const char *name, const char *argument, char *out_text,
                            int32_t text_size)
{
    heard *h = context;
    h->commands += 1;
    snprintf(h->name, sizeof h->name, "%s", name);
    snprintf(h->argument, sizeof h->argument, "%s", argument);
    assert_int_equal(out_text[0], 0);
    assert_true(text_size >= 256);
    memset(out_text, 'x', (size_t)text_size); /* a handler that forgets the NUL */
    snprintf(out_text, (size_t)text_size, "refused: %s", argument);
    return 1;
}

static void hear_message(const lcm_recv_buf_t *message, const char *channel, void *user)
{
    heard *h = user;
    h->messages += 1;
    snprintf(h->channel, sizeof h->channel, "%s", channel);
    h->size = (int)message->data_size;
    memcpy(h->data, message->data, message->data_size);
}

static ss_net *net_make(heard *h, bool is_lockstep, const char *prefix)
{
    memset(h, 0, sizeof *h);
    const ss_net_config config = {
        .lcm_url = "memq://", .prefix = prefix, .is_lockstep = is_lockstep};
    const ss_net_calls calls = {h, hear_pose, hear_refusal, hear_command};
    softsim_error error = {.status = SOFTSIM_OK};
    ss_net *net = NULL;
    assert_int_equal(ss_net_open(&config, &calls, &net, &error), SOFTSIM_OK);
    assert_non_null(net);
    return net;
}

static void publish_pose(ss_net *net, const char *channel)
{
    uint8_t message[MESSAGE_SIZE];
    lcm_publish(ss_net_lcm(net), channel, message, (unsigned)encode_pose(message));
}

TEST(poses_reach_their_handler_and_refusals_theirs)
{
    static heard h;
    uint8_t message[MESSAGE_SIZE];
    ss_net *net = net_make(&h, false, "SOFTSIM");
    lcm_t *lcm = ss_net_lcm(net);
    const unsigned size = (unsigned)encode_pose(message);
    assert_true(ss_net_wait(net, -1, 0));
    assert_int_equal(h.poses, 0);
    lcm_publish(lcm, "SOFTSIM_PROBE_3", message, size);
    lcm_publish(lcm, "SOFTSIM_PROBE_8", message, size); /* no such channel */
    assert_true(ss_net_wait(net, -1, 0));
    assert_int_equal(h.poses, 1);
    assert_int_equal(h.last_channel, 3);
    assert_int_equal(h.pose.seq, 42);
    assert_true(h.receive_ns > 0);
    assert_int_equal(h.pose.receive_ns, h.receive_ns);
    /* All that is there in one wake, in order, nothing lost. */
    for (int i = 0; i < 200; ++i) {
        lcm_publish(lcm, "SOFTSIM_PROBE_7", message, size);
    }
    lcm_publish(lcm, "SOFTSIM_PROBE_0", message, size - 1);
    lcm_publish(lcm, "SOFTSIM_PROBE_0", message, 0);
    message[0] ^= 1;
    lcm_publish(lcm, "SOFTSIM_PROBE_0", message, size);
    lcm_publish(lcm, "SOFTSIM_COMMAND", message, size);
    assert_true(ss_net_wait(net, -1, 0));
    assert_int_equal(h.poses, 201);
    assert_int_equal(h.refusals[SOFTSIM_REFUSED_MALFORMED], 2);
    assert_int_equal(h.refusals[SOFTSIM_REFUSED_TYPE_HASH], 2);
    assert_int_equal(h.last_channel, -1);
    ss_net_close(&net);
    assert_null(net);
    ss_net_close(&net);
}

TEST(in_lockstep_poses_carry_no_receive_time)
{
    static heard h;
    ss_net *net = net_make(&h, true, "SOFTSIM");
    publish_pose(net, "SOFTSIM_PROBE_0");
    assert_true(ss_net_wait(net, -1, 0));
    assert_int_equal(h.poses, 1);
    assert_int_equal(h.receive_ns, 0);
    assert_int_equal(h.pose.receive_ns, 0);
    ss_net_close(&net);
}

TEST(a_dot_in_the_prefix_is_a_dot)
{
    static heard h;
    ss_net *net = net_make(&h, false, "a.b-c");
    publish_pose(net, "a.b-c_PROBE_0");
    publish_pose(net, "aXb-c_PROBE_0");
    publish_pose(net, "Xa.b-c_PROBE_0");
    assert_true(ss_net_wait(net, -1, 0));
    assert_int_equal(h.poses, 1);
    ss_net_close(&net);
}

TEST(a_signal_ends_the_wait_and_is_drained)
{
    static heard h;
    ss_net *net = net_make(&h, false, "SOFTSIM");
    const int fd = ss_wake_open();
    ss_wake_signal(fd);
    assert_true(ss_net_wait(net, fd, 60000));
    struct pollfd waiting = {.fd = fd, .events = POLLIN};
    assert_int_equal(poll(&waiting, 1, 0), 0);
    close(fd);
    ss_net_close(&net);
}

TEST(a_command_is_answered_with_its_sender_and_id)
{
    static heard h;
    uint8_t message[MESSAGE_SIZE];
    ss_net *net = net_make(&h, false, "T");
    lcm_t *lcm = ss_net_lcm(net);
    lcm_subscribe(lcm, "T_REPLY", hear_message, &h);
    const int size = encode_command(message, "set", "a.b=1");
    for (int32_t round = 1; round <= 2; ++round) {
        lcm_publish(lcm, "T_COMMAND", message, (unsigned)size);
        assert_true(ss_net_wait(net, -1, 0));
        assert_int_equal(h.commands, round);
        assert_string_equal(h.name, "set");
        assert_string_equal(h.argument, "a.b=1");
        assert_int_equal(h.messages, round);
        softsim_reply_t reply;
        assert_int_equal(softsim_reply_t_decode(h.data, 0, h.size, &reply), h.size);
        assert_int_equal(reply.sender, 8);
        assert_int_equal(reply.id, 6);
        assert_int_equal(reply.seq, round);
        assert_int_equal(reply.code, 1);
        assert_true(reply.utime > 0);
        assert_string_equal(reply.text, "refused: a.b=1");
        softsim_reply_t_decode_cleanup(&reply);
    }
    ss_net_close(&net);
}

TEST(a_force_is_sent_as_it_is)
{
    static heard h;
    ss_net *net = net_make(&h, false, "T");
    lcm_subscribe(ss_net_lcm(net), "T_FORCE_5", hear_message, &h);
    softsim_force force = {.utime_us = 11,
                           .sender = 12,
                           .pose_utime_us = 13,
                           .seq = 14,
                           .probe = 5,
                           .pose_seq = 15,
                           .contact_count = 2,
                           .model_age_us = 16,
                           .flags = SOFTSIM_FORCE_CONTACT | SOFTSIM_FORCE_GRASPING,
                           .force = {1, 2, 3},
                           .torque = {4, 5, 6},
                           .model_force = {7, 8, 9},
                           .point = {10, 11, 12},
                           .normal = {0, 0, 1},
                           .proxy = {13, 14, 15},
                           .depth = 0.001,
                           .stiffness = 345.6};
    assert_true(ss_net_send_force(net, &force));
    assert_true(ss_net_wait(net, -1, 0));
    assert_int_equal(h.messages, 1);
    softsim_contact_force_t wire;
    assert_int_equal(softsim_contact_force_t_decode(h.data, 0, h.size, &wire), h.size);
    assert_int_equal(wire.utime, 11);
    assert_int_equal(wire.sender, 12);
    assert_int_equal(wire.pose_utime, 13);
    assert_int_equal(wire.seq, 14);
    assert_int_equal(wire.probe, 5);
    assert_int_equal(wire.pose_seq, 15);
    assert_int_equal(wire.contact_count, 2);
    assert_int_equal(wire.model_age_us, 16);
    assert_int_equal(wire.flags, 129);
    assert_memory_equal(wire.force, force.force, sizeof wire.force);
    assert_memory_equal(wire.torque, force.torque, sizeof wire.torque);
    assert_memory_equal(wire.model_force, force.model_force, sizeof wire.model_force);
    assert_memory_equal(wire.point, force.point, sizeof wire.point);
    assert_memory_equal(wire.normal, force.normal, sizeof wire.normal);
    assert_memory_equal(wire.proxy, force.proxy, sizeof wire.proxy);
    assert_true(wire.depth == 0.001 && wire.stiffness == 345.6);
    /* Without a time of its own it gets one; without a channel it is dropped and counted. */
    force.utime_us = 0;
    assert_true(ss_net_send_force(net, &force));
    assert_true(ss_net_wait(net, -1, 0));
    softsim_contact_force_t_decode(h.data, 0, h.size, &wire);
    assert_true(wire.utime > 0);
    assert_int_equal(ss_net_dropped(net), 0);
    force.probe = 8;
    assert_false(ss_net_send_force(net, &force));
    force.probe = -1;
    assert_false(ss_net_send_force(net, &force));
    assert_int_equal(ss_net_dropped(net), 2);
    ss_net_close(&net);
}

TEST(status_is_sent_as_it_is_and_its_texts_are_bounded)
{
    static heard h;
    static char endless[100000];
    ss_net *net = net_make(&h, false, "T");
    lcm_subscribe(ss_net_lcm(net), "T_STATUS", hear_message, &h);
    memset(endless, 'r', sizeof endless - 1);
    softsim_server_status report = {.verdict = SOFTSIM_VERDICT_DEGRADED,
                                    .nodes = 1234,
                                    .state_hash = INT64_MIN,
                                    .poses_refused = {1, 2, 3, 4, 5, 6, 7, 8},
                                    .probe_periods = {9, 0, 0, 0, 0, 0, 0, 10},
                                    .step_us = {1.5, 2.5, 3.5},
                                    .lateness_us = {4, 5, 6, 7},
                                    .worst_contact_j = {-1e-3},
                                    .loop_delay_ms = {8, 9},
                                    .stiffness_limit_n_per_m = {0, 0, 0, 0, 0, 0, 0, 500},
                                    .scene = "liver",
                                    .reason = endless};
    assert_true(ss_net_send_status(net, &report));
    assert_true(ss_net_wait(net, -1, 0));
    softsim_server_status_t wire;
    assert_int_equal(softsim_server_status_t_decode(h.data, 0, h.size, &wire), h.size);
    assert_int_equal(wire.seq, 1);
    assert_int_equal(wire.verdict, 2);
    assert_int_equal(wire.nodes, 1234);
    assert_true(wire.state_hash == INT64_MIN);
    assert_memory_equal(wire.poses_refused, report.poses_refused, sizeof wire.poses_refused);
    assert_memory_equal(wire.probe_periods, report.probe_periods, sizeof wire.probe_periods);
    assert_memory_equal(wire.step_us, report.step_us, sizeof wire.step_us);
    assert_memory_equal(wire.lateness_us, report.lateness_us, sizeof wire.lateness_us);
    assert_memory_equal(wire.worst_contact_j, report.worst_contact_j, sizeof wire.worst_contact_j);
    assert_memory_equal(wire.loop_delay_ms, report.loop_delay_ms, sizeof wire.loop_delay_ms);
    assert_memory_equal(wire.stiffness_limit_n_per_m, report.stiffness_limit_n_per_m,
                        sizeof wire.stiffness_limit_n_per_m);
    assert_string_equal(wire.scene, "liver");
    assert_string_equal(wire.model, "");
    assert_int_equal(strlen(wire.reason), 1023);
    softsim_server_status_t_decode_cleanup(&wire);
    ss_net_close(&net);
}

/* Multicast brings back what we send: our own statuses are known, another server's are not. */
TEST(another_server_is_told_from_ourselves)
{
    static heard h;
    ss_net *net = net_make(&h, false, "R");
    const softsim_server_status report = {.scene = "s", .model = "m", .reason = ""};
    for (int i = 0; i < 2000; ++i) { /* more than are remembered */
        assert_true(ss_net_send_status(net, &report));
        assert_true(ss_net_wait(net, -1, 1000));
    }
    assert_true(ss_net_other_server(net)->last_ns == 0);
    static char text[] = "", scene[] = "kidney.yaml";
    softsim_server_status_t wire = {.utime = 1,
                                    .seq = 2000,
                                    .verdict = 3,
                                    .uptime_s = 12.5,
                                    .simulation_rate_hz = 3.0,
                                    .stiffness_backoffs = 4,
                                    .scene = scene,
                                    .model = text,
                                    .reason = text};
    uint8_t message[MESSAGE_SIZE];
    const int size = softsim_server_status_t_encode(message, 0, sizeof message, &wire);
    const int used = size - 2 * 5; /* what comes after the scene is not looked at */
    ss_net_status status;
    for (int n = 0; n < used; ++n) {
        void *copy = exact_copy(message, n);
        assert_int_equal(ss_net_decode_status(copy, n, &status), SOFTSIM_REFUSED_MALFORMED);
        free(copy);
        lcm_publish(ss_net_lcm(net), "R_STATUS", message, (unsigned)n);
        assert_true(ss_net_wait(net, -1, 1000));
    }
    assert_true(ss_net_other_server(net)->last_ns == 0);
    lcm_publish(ss_net_lcm(net), "R_STATUS", message, (unsigned)size);
    assert_true(ss_net_wait(net, -1, 1000));
    const ss_other_server *other = ss_net_other_server(net);
    assert_true(other->last_ns != 0 && other->status.uptime_s == 12.5);
    assert_int_equal(other->status.utime_us, 1);
    assert_int_equal(other->status.seq, 2000);
    assert_string_equal(other->status.scene, scene);
    /* What it says may not drive a terminal. */
    static char hostile[] = "k\x9b\xc2\x9b \xc3\xa4";
    softsim_server_status_t spoken = wire;
    spoken.scene = hostile;
    const int spoken_size = softsim_server_status_t_encode(message, 0, sizeof message, &spoken);
    assert_int_equal(ss_net_decode_status(message, spoken_size, &status), SOFTSIM_ACCEPTED);
    assert_string_equal(status.scene, "k??? \xc3\xa4");
    static const double bad[] = {-1.0, 1e11, (double)INFINITY, (double)NAN};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
        wire.uptime_s = bad[k];
        softsim_server_status_t_encode(message, 0, sizeof message, &wire);
        assert_int_equal(ss_net_decode_status(message, size, &status), SOFTSIM_REFUSED_MALFORMED);
    }
    ss_net_close(&net);
}

/* A server's command to the others must not be taken for one to itself. */
TEST(own_commands_are_passed_over)
{
    static heard h;
    ss_net *net = net_make(&h, false, "R");
    lcm_subscribe(ss_net_lcm(net), "R_COMMAND", hear_message, &h);
    ss_net_send_command(net, "shutdown");
    assert_true(ss_net_wait(net, -1, 1000));
    ss_net_command command;
    assert_int_equal(ss_net_decode_command(h.data, h.size, &command), SOFTSIM_ACCEPTED);
    assert_string_equal(command.name, "shutdown");
    assert_true(command.sender != 0);
    assert_int_equal(h.commands, 0);
    ss_net_close(&net);
}

/* ---- the server that stays ---- */

enum { SECOND_NS = 1000000000 };

static ss_net_status status_of(double start_s, double clock_s, double now_s)
{
    const ss_net_status status = {
        .utime_us = llround(1e6 * (clock_s + now_s)), .uptime_s = now_s - start_s, .scene = "s"};
    return status;
}

TEST(only_a_server_that_stays_counts)
{
    ss_other_server other = {0};
    assert_false(ss_other_server_is_alive(&other, 5 * (int64_t)SECOND_NS));
    for (int k = 0; k < 3; ++k) { /* the last word of one that ends */
        const ss_net_status status = status_of(1.0, 0.0, 10.0 + 0.05 * k);
        ss_other_server_hear(&other, &status, 10 * (int64_t)SECOND_NS + k * 50000000);
        assert_false(ss_other_server_is_alive(&other, 10 * (int64_t)SECOND_NS + k * 50000000));
    }
    for (int k = 0; k < 9; ++k) { /* of two the first counts, however often the other speaks */
        const ss_net_status status = status_of(k % 2 == 0 ? 1.0 : 2.0, 0.0, 10.0 + 0.25 * k);
        ss_other_server_hear(&other, &status, 10 * (int64_t)SECOND_NS + k * 250000000);
        assert_true(other.status.uptime_s == 9.0 + 0.25 * (k - k % 2));
    }
    assert_true(ss_other_server_is_alive(&other, 12 * (int64_t)SECOND_NS));
    assert_false(ss_other_server_is_alive(&other, 14 * (int64_t)SECOND_NS));
    const ss_net_status later = status_of(13.0, 0.0, 14.0);
    ss_other_server_hear(&other, &later, 14 * (int64_t)SECOND_NS);
    assert_false(ss_other_server_is_alive(&other, 14 * (int64_t)SECOND_NS));
}

/* Whatever the delays and the clocks of two hosts: never both, and soon one. */
TEST(of_two_servers_at_most_one_gives_way)
{
    static const double apart_s[] = {1e-6, 1e-3, 0.2, 0.9, 1.1, 30.0};
    static const double clock_s[] = {0.0, 1000.0, -1000.0};
    static const double delay_s[] = {0.0, 0.01, 0.3, 0.95};
    for (size_t a = 0; a < sizeof apart_s / sizeof *apart_s; ++a) {
        for (size_t c = 0; c < sizeof clock_s / sizeof *clock_s; ++c) {
            for (size_t d = 0; d < sizeof delay_s / sizeof *delay_s; ++d) {
                const double now_s = 100.0, elder_s = 50.0, younger_s = elder_s + apart_s[a];
                const ss_other_server elder = {
                    .status = status_of(elder_s, clock_s[c], now_s - delay_s[d])};
                const ss_other_server younger = {.status =
                                                     status_of(younger_s, 0.0, now_s - delay_s[d])};
                const bool goes =
                    ss_other_server_is_senior(&elder, now_s - younger_s, llround(1e6 * younger_s));
                const bool elder_goes = ss_other_server_is_senior(
                    &younger, now_s - elder_s, llround(1e6 * (elder_s + clock_s[c])));
                assert_false(goes && elder_goes);
                assert_true(clock_s[c] != 0.0 || !elder_goes); /* one host: the true order */
                assert_true(goes || elder_goes || apart_s[a] > 1.0 || clock_s[c] > 0.0);
                assert_true(delay_s[d] > 0.01 || goes || elder_goes);
            }
        }
    }
}

static void expect_bad_address(const char *url, const char *prefix, const char *hint)
{
    const ss_net_calls calls = {NULL, hear_pose, hear_refusal, hear_command};
    const double rest[1][3] = {{0, 0, 0}};
    const ss_publish_mesh mesh = {.node_count = 1, .rest = rest, .diagonal = 1.0};
    softsim_error error = {.status = SOFTSIM_OK};
    const ss_net_config config = {.lcm_url = url, .prefix = prefix};
    ss_net *net = NULL;
    assert_int_equal(ss_net_open(&config, &calls, &net, &error), SOFTSIM_ERROR_ARGUMENT);
    assert_null(net);
    assert_non_null(strstr(error.text, hint));
    const ss_publisher_config publisher_config = {
        .lcm_url = url, .prefix = prefix, .max_bytes_per_s = 1e6};
    ss_publisher *publisher = NULL;
    assert_int_equal(ss_publisher_open(&publisher_config, &mesh, &publisher, &error),
                     SOFTSIM_ERROR_ARGUMENT);
    assert_null(publisher);
}

TEST(bad_urls_are_refused_with_a_hint)
{
    static const char group[] = "udpm://239.255.76.67:7667";
    static const says_row other[] = {
        {"tcpq://127.0.0.1:7700", "udpm://"},
        {"file:///tmp/x.lcmlog", "softsim-replay"},
        {"nonsense", "udpm://"},
    };
    static const char *const no_group[] = {
        "udpm://127.0.0.1:7667?ttl=0",
        "udpm://239.255.76.67:0",
        "udpm://239.255.76.67:70000",
        "udpm://239.255.76.67:76x",
        "udpm://group.example:7667",
        "udpm://2399999999999999999999999999999999999999999999999999999999999999999999.1"};
    static const char *const no_ttl[] = {"-1", "999999999999", "256", "1.5", ""};
    char url[80];
    for (size_t k = 0; k < sizeof other / sizeof *other; ++k) {
        expect_bad_address(other[k].given, "T", other[k].says);
    }
    for (size_t k = 0; k < sizeof no_group / sizeof *no_group; ++k) {
        expect_bad_address(no_group[k], "T", "multicast");
    }
    for (size_t k = 0; k < sizeof no_ttl / sizeof *no_ttl; ++k) {
        (void)snprintf(url, sizeof url, "%s?ttl=%s", group, no_ttl[k]);
        expect_bad_address(url, "T", "ttl is a whole number");
    }
    (void)snprintf(url, sizeof url, "%s?ttl=0&recv_buf_size=-5", group);
    expect_bad_address(url, "T", "recv_buf_size is");
    (void)snprintf(url, sizeof url, "%s?tll=0", group);
    expect_bad_address(url, "T", "its options are");
}

TEST(bad_prefixes_are_refused_with_a_hint)
{
    static const char *const bad[] = {"",   NULL,  "A B",
                                      "A*", "A/B", "12345678901234567890123456789012345678901"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
        expect_bad_address("memq://", bad[k], "prefix");
    }
}

TEST(an_urls_parts_are_read)
{
    static const struct {
        const char *url;
        int port, ttl, buffer;
    } cases[] = {{"udpm://", 7667, 0, 0},
                 {"udpm://239.1.2.3", 7667, 0, 0},
                 {"udpm://:7000?ttl=3", 7000, 3, 0},
                 {"udpm://239.255.76.67:7667?recv_buf_size=65536&ttl=255", 7667, 255, 65536}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        softsim_error error = {.status = SOFTSIM_OK};
        ss_wire_url url;
        assert_true(ss_wire_read_url(cases[c].url, &url, &error));
        assert_int_equal(ntohs(url.group.sin_port), cases[c].port);
        assert_int_equal(url.ttl, cases[c].ttl);
        assert_int_equal(url.buffer, cases[c].buffer);
        assert_true(ss_net_is_own_url(cases[c].url));
    }
}

TEST(a_url_of_ones_own_is_given_or_in_the_environment)
{
    char before[256] = "";
    const char *outer = getenv("LCM_DEFAULT_URL");
    snprintf(before, sizeof before, "%s", outer != NULL ? outer : "");
    unsetenv("LCM_DEFAULT_URL");
    assert_false(ss_net_is_own_url(NULL));
    assert_false(ss_net_is_own_url(""));
    assert_true(ss_net_is_own_url("udpm://239.255.76.67:7667?ttl=0"));
    setenv("LCM_DEFAULT_URL", "udpm://239.255.76.67:7667?ttl=1", 1);
    assert_true(ss_net_is_own_url(NULL));
    ss_wire_url url;
    softsim_error error = {.status = SOFTSIM_OK};
    assert_true(ss_wire_read_url(NULL, &url, &error));
    assert_int_equal(url.ttl, 1);
    setenv("LCM_DEFAULT_URL", before, 1);
}

/* Beyond the budget commands are counted and not answered. */
TEST(commands_have_a_budget)
{
    static heard h;
    uint8_t message[MESSAGE_SIZE];
    ss_net *net = net_make(&h, false, "T");
    const int size = encode_command(message, "status", "");
    for (int i = 0; i < 5000; ++i) {
        lcm_publish(ss_net_lcm(net), "T_COMMAND", message, (unsigned)size);
        assert_true(ss_net_wait(net, -1, 0));
    }
    assert_true(h.commands >= 20);
    assert_true(h.refusals[SOFTSIM_REFUSED_OTHER] > 0);
    assert_int_equal(h.commands + h.refusals[SOFTSIM_REFUSED_OTHER], 5000);
    ss_net_close(&net);
}

/* Forces must not wait behind a flood of poses. */
TEST(a_signal_interrupts_a_flood)
{
    static heard h;
    uint8_t message[MESSAGE_SIZE];
    ss_net *net = net_make(&h, false, "SOFTSIM");
    const unsigned size = (unsigned)encode_pose(message);
    h.signal_fd = ss_wake_open();
    for (int i = 0; i < 100; ++i) {
        lcm_publish(ss_net_lcm(net), "SOFTSIM_PROBE_0", message, size);
    }
    for (int i = 1; i <= 100; ++i) {
        assert_true(ss_net_wait(net, h.signal_fd, 60000));
        assert_int_equal(h.poses, i);
    }
    close(h.signal_fd);
    ss_net_close(&net);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
