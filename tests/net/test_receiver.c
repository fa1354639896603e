/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * net/receiver and net/filter, on real sockets in a private network namespace: what the kernel lets
 * in, what a lane may take of a thread, and that a datagram is never read beyond its end.
 */

#include "common/test.h"

#include <arpa/inet.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "net/receiver.h"
#include "net/wire.h"
#include "process/process.h"
#include "rt/budget.h"
#include "rt/clock.h"
#include "rt/thread.h"

enum { SIZE = 100, MARK = 1 /* bytes: the size of a mark */, PORT = 7667 };
static const char GROUP[] = "239.255.76.67";

/* ---- datagrams ---- */

/* LCM's head, the channel with its NUL, `size` zeros. Returns the datagram's size. */
static int make(uint8_t *out, const char *magic, const char *channel, int size)
{
    memset(out, 0, 8);
    memcpy(out, magic, 4);
    strcpy((char *)out + 8, channel);
    const int head = 8 + (int)strlen(channel) + 1;
    memset(out + head, 0, (size_t)size);
    return head + size;
}

static int sender_open(int ttl)
{
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    assert_true(fd >= 0);
    assert_int_equal(setsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl), 0);
    return fd;
}

static void send_to(int fd, const char *address, const void *data, int size)
{
    const struct sockaddr_in to = {
        .sin_family = AF_INET, .sin_port = htons(PORT), .sin_addr.s_addr = inet_addr(address)};
    assert_int_equal(sendto(fd, data, (size_t)size, 0, (const struct sockaddr *)&to, sizeof to),
                     size);
}

static void send_message(int fd, const char *channel, int size)
{
    uint8_t datagram[4096];
    send_to(fd, GROUP, datagram, make(datagram, "LC02", channel, size));
}

/* ---- a receiver that notes what it hears ---- */

typedef struct heard {
    int poses, others, pose_marks, other_marks, digit, name, size;
    uint64_t source;
    char channel[64];
} heard;

static void note(heard *h, const ss_packet *packet, int *count, int *marks)
{
    if (packet->size == MARK) {
        ++*marks;
        return;
    }
    ++*count;
    h->digit = packet->digit;
    h->name = packet->name;
    h->size = packet->size;
    h->source = packet->source;
    snprintf(h->channel, sizeof h->channel, "%s", packet->channel);
}

static void hear_pose(void *context, const ss_packet *packet)
{
    heard *h = context;
    note(h, packet, &h->poses, &h->pose_marks);
}

static void hear_other(void *context, const ss_packet *packet)
{
    heard *h = context;
    note(h, packet, &h->others, &h->other_marks);
}

static const ss_lane lanes[] = {{.suffix = {"_PROBE_#"},
                                 .max_size = SIZE,
                                 .buffer = 2097152,
                                 .per_ms = 10,
                                 .burst = 20,
                                 .receive = hear_pose},
                                {.suffix = {"_COMMAND", "_STATUS"},
                                 .max_size = SIZE,
                                 .buffer = 212992,
                                 .per_ms = 4,
                                 .burst = 64,
                                 .receive = hear_other}};

static lcm_t *lcm;

static ss_receiver *open_lanes(heard *h, const char *url, const char *prefix,
                               const ss_lane two_lanes[])
{
    softsim_error error = {.status = SOFTSIM_OK};
    ss_receiver *receiver = NULL;
    memset(h, 0, sizeof *h);
    lcm = ss_wire_open(url, &error);
    const ss_receiver_config config = {.lcm_url = url,
                                       .lcm = lcm,
                                       .prefix = prefix,
                                       .lane = two_lanes,
                                       .lane_count = 2,
                                       .context = h};
    if (lcm == NULL || ss_receiver_open(&config, &receiver, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return receiver;
}

static ss_receiver *open_receiver(heard *h, const char *url, const char *prefix)
{
    return open_lanes(h, url, prefix, lanes);
}

static void close_receiver(ss_receiver **receiver)
{
    ss_receiver_close(receiver);
    assert_null(*receiver);
    lcm_destroy(lcm);
}

/* Each lane reads in order: what was sent before the marks and is not heard was not let in. */
static void hear_all(ss_receiver *receiver, heard *h, int fd)
{
    const int pose_marks = h->pose_marks, other_marks = h->other_marks;
    send_message(fd, "T_PROBE_0", MARK);
    send_message(fd, "T_STATUS", MARK);
    while (h->pose_marks == pose_marks || h->other_marks == other_marks) {
        assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 60000000000) > 0);
    }
}

/* ---- the kernel's filter ---- */

TEST(the_kernel_lets_in_whole_messages_of_our_channels)
{
    static const struct {
        const char *magic, *channel;
        int size;
        bool is_ours;
    } cases[] = {
        {"LC02", "T_PROBE_0", SIZE, true},      {"LC02", "T_PROBE_7", SIZE, true},
        {"LC02", "T_PROBE_3", 0, true},         {"LC02", "T_COMMAND", SIZE, true},
        {"LC02", "T_COMMAND", 0, true},         {"LC02", "T_PROBE_8", SIZE, false},
        {"LC02", "T_PROBE_/", SIZE, false},     {"LC02", "T_PROBE_", SIZE, false},
        {"LC02", "T_PROBE_00", SIZE, false},    {"LC02", "U_PROBE_0", SIZE, false},
        {"LC02", "TT_PROBE_0", SIZE, false},    {"LC02", "T_COMMANDS", SIZE, false},
        {"LC02", "T_COMMAN", SIZE, false},      {"LC02", "", SIZE, false},
        {"LC02", "LCM_SELF_TEST", 8, false},    {"LC03", "T_PROBE_0", SIZE, false},
        {"LC01", "T_PROBE_0", SIZE, false},     {"\0\0\0\0", "T_PROBE_0", SIZE, false},
        {"LC02", "T_PROBE_0", SIZE + 1, false}, {"LC02", "T_COMMAND", SIZE + 1, false},
        {"LC02", "T_PROBE_0", 65000, false},
    };
    heard h;
    ss_receiver *receiver = open_receiver(&h, NULL, "T");
    const int fd = sender_open(0);
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        static uint8_t datagram[65500];
        const int size = make(datagram, cases[c].magic, cases[c].channel, cases[c].size);
        const int before = h.poses + h.others;
        send_to(fd, GROUP, datagram, size);
        hear_all(receiver, &h, fd);
        if (h.poses + h.others - before != cases[c].is_ours) {
            fail_msg("%s %s", cases[c].magic, cases[c].channel);
        }
    }
    /* Cut anywhere, a message is refused, or is one with less in it; no byte is read that is not
     * there. */
    uint8_t datagram[512];
    const int whole = make(datagram, "LC02", "T_PROBE_5", SIZE);
    for (int size = 0; size <= whole; size += size == whole - SIZE ? MARK + 1 : 1) {
        const int before = h.poses;
        send_to(fd, GROUP, datagram, size);
        hear_all(receiver, &h, fd);
        assert_int_equal(h.poses - before, size >= whole - SIZE);
    }
    close(fd);
    close_receiver(&receiver);
}

TEST(a_message_says_what_it_is_and_who_sent_it)
{
    heard h;
    ss_receiver *receiver = open_receiver(&h, NULL, "T");
    const int fd[] = {sender_open(0), sender_open(0)};
    uint64_t source[2];
    for (int i = 0; i < 2; ++i) {
        send_message(fd[i], "T_PROBE_6", 10 + i);
        while (h.poses == i) {
            assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 60000000000) >= 0);
        }
        assert_string_equal(h.channel, "T_PROBE_6");
        assert_int_equal(h.digit, 6);
        assert_int_equal(h.name, 0);
        assert_int_equal(h.size, 10 + i);
        struct sockaddr_in own;
        socklen_t own_size = sizeof own;
        assert_int_equal(getsockname(fd[i], (struct sockaddr *)&own, &own_size), 0);
        assert_int_equal(h.source & 0xffff, ntohs(own.sin_port));
        source[i] = h.source;
    }
    assert_true(source[0] != source[1]);
    send_message(fd[0], "T_STATUS", SIZE);
    hear_all(receiver, &h, fd[0]);
    assert_int_equal(h.name, 1);
    assert_int_equal(h.digit, -1);
    assert_true(h.source == source[0]);
    close(fd[0]);
    close(fd[1]);
    close_receiver(&receiver);
}

TEST(only_this_host_is_heard_with_a_ttl_of_zero)
{
    heard h;
    const int fd = sender_open(0), far = sender_open(1);
    uint8_t datagram[512];
    const int size = make(datagram, "LC02", "T_PROBE_0", SIZE);
    ss_receiver *receiver = open_receiver(&h, NULL, "T");
    send_message(far, "T_PROBE_0", SIZE);
    send_to(fd, "127.0.0.1", datagram, size);
    hear_all(receiver, &h, fd);
    assert_int_equal(h.poses, 0);
    close_receiver(&receiver);
    receiver = open_receiver(&h, "udpm://239.255.76.67:7667?ttl=1", "T");
    send_to(fd, "127.0.0.1", datagram, size); /* never what was not sent to the group */
    send_message(far, "T_PROBE_0", SIZE);
    hear_all(receiver, &h, fd);
    assert_int_equal(h.poses, 1);
    close_receiver(&receiver);
    close(fd);
    close(far);
}

/* Every message of a channel that two lanes share comes in one of them. */
TEST(a_part_of_the_message_chooses_between_lanes)
{
    static const char part[] = "part of it"; /* two words and three bytes */
    enum { AT = 7 };
    ss_lane shared[2];
    for (int i = 0; i < 2; ++i) {
        shared[i] = lanes[i];
        shared[i].suffix[0] = "_COMMAND";
        shared[i].suffix[1] = NULL;
        shared[i].part =
            (ss_filter_part){.at = AT, .bytes = part, .size = sizeof part, .is_unwanted = i == 1};
    }
    heard h;
    ss_receiver *receiver = open_lanes(&h, NULL, "T", shared);
    const int fd = sender_open(0);
    const int whole = AT + (int)sizeof part;
    /* With the part, at a wrong place, wrong in each byte; cut at every length; longer. */
    for (int c = -2; c < 2 * whole + 2; ++c) {
        uint8_t datagram[512];
        const int shift = c == -2 ? 1 : 0;
        const int size = c < whole ? whole + shift : c - whole + (c >= 2 * whole ? 50 : 0);
        const int made = make(datagram, "LC02", "T_COMMAND", size);
        uint8_t *message = datagram + made - size;
        uint8_t text[128] = {0};
        memcpy(text + AT + shift, part, sizeof part);
        text[c >= 0 && c < whole ? c : 100] ^= 1;
        memcpy(message, text, (size_t)size);
        const bool has_part = size >= whole && memcmp(message + AT, part, sizeof part) == 0;
        const int parts = h.poses + h.pose_marks, rests = h.others + h.other_marks;
        ss_packet packet;
        assert_int_equal(ss_receiver_parse(&shared[0], "T", datagram, made, &packet), has_part);
        assert_int_equal(ss_receiver_parse(&shared[1], "T", datagram, made, &packet), !has_part);
        send_to(fd, GROUP, datagram, made);
        while (h.poses + h.pose_marks == parts && h.others + h.other_marks == rests) {
            assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 60000000000) >= 0);
        }
        assert_int_equal(h.poses + h.pose_marks - parts, has_part);
        assert_int_equal(h.others + h.other_marks - rests, !has_part);
    }
    close(fd);
    close_receiver(&receiver);
}

/* ---- budgets ---- */

TEST(a_budget_fills_up_and_no_further)
{
    ss_budget budget = {.interval_ns = 100, .burst = 5};
    assert_int_equal(ss_budget_left(&budget, 1000000), 5);
    ss_budget_spend(&budget, 5);
    assert_int_equal(ss_budget_left(&budget, 1000000), 0);
    assert_int_equal(ss_budget_left(&budget, 1000099), 0);
    assert_int_equal(ss_budget_when(&budget, 1), 1000100);
    assert_int_equal(ss_budget_left(&budget, 1000100), 1);
    assert_int_equal(ss_budget_left(&budget, 1000399), 3);
    ss_budget_spend(&budget, 2);
    assert_int_equal(ss_budget_left(&budget, 1000399), 1);
    assert_int_equal(ss_budget_left(&budget, 9000000), 5);
}

TEST(a_flood_is_read_no_faster_than_the_budget)
{
    enum { FLOOD = 2000 };
    heard h;
    ss_receiver *receiver = open_receiver(&h, NULL, "T");
    const int fd = sender_open(0);
    for (int i = 0; i < FLOOD; ++i) {
        send_message(fd, "T_PROBE_0", SIZE);
    }
    const int64_t start_ns = ss_clock_now_ns();
    while (h.poses < 300) {
        assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 60000000000) >= 0);
        const int64_t took_ms = (ss_clock_now_ns() - start_ns) / 1000000;
        assert_true(h.poses <= 20 + 10 * (took_ms + 1));
    }
    /* The flood waits; another lane does not wait behind it. */
    send_message(fd, "T_STATUS", MARK);
    while (h.other_marks == 0) {
        assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 60000000000) > 0);
    }
    assert_true(h.poses < FLOOD);
    close(fd);
    close_receiver(&receiver);
}

/* A lane that has spent its budget is left until there is enough for a batch, however often others
 * wake the thread up: read one by one, a message costs five times as much. */
TEST(a_flood_is_read_in_batches_whoever_else_speaks)
{
    enum { FLOOD = 400, BATCH = 32 };
    ss_lane slow[2] = {lanes[0], lanes[1]};
    heard h;
    slow[0].per_ms = 100;
    slow[0].burst = 1024;
    ss_receiver *receiver = open_lanes(&h, NULL, "T", slow);
    const int fd = sender_open(0);
    for (int i = 0; i < FLOOD; ++i) {
        send_message(fd, "T_STATUS", SIZE);
    }
    int readings = 0;
    while (h.others < FLOOD) {
        const int before = h.others;
        send_message(fd, "T_PROBE_0", SIZE);
        assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 60000000000) > 0);
        readings += h.others > before;
    }
    /* Behind each there may be one of what came in late. */
    assert_in_range(readings, 1, 2 * FLOOD / BATCH);
    close(fd);
    close_receiver(&receiver);
}

/* One sender alone may say `per_s` messages a second on the second lane, but for `followed`. */
static ss_receiver *open_strict(heard *h, int32_t per_s, const uint64_t *followed)
{
    ss_lane strict[2] = {lanes[0], lanes[1]};
    strict[1].sender_per_s = per_s;
    strict[1].followed = followed;
    return open_lanes(h, NULL, "T", strict);
}

/* What one sender fills the buffer with leaves no room for others: beyond what one may say nothing
 * of it comes into the buffer, for a time. */
TEST(a_sender_who_says_too_much_is_muted)
{
    enum { MAY_SAY = 40, SAYS = 400, FLOOD = 20000 };
    heard h = {0};
    ss_receiver *receiver = open_strict(&h, MAY_SAY, NULL);
    const int flooder = sender_open(0), other = sender_open(0);
    for (int i = 0; i < SAYS; ++i) {
        send_message(flooder, "T_STATUS", SIZE);
    }
    send_message(other, "T_STATUS", MARK);
    while (h.other_marks < 1) {
        assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 1000000000) >= 0);
    }
    const int said = h.others;
    assert_in_range(said, MAY_SAY, SAYS - 1);
    for (int i = 0; i < FLOOD; ++i) { /* forty times the buffer */
        send_message(flooder, "T_STATUS", SIZE);
    }
    send_message(other, "T_STATUS", MARK);
    while (h.other_marks < 2) {
        assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 60000000000) > 0);
    }
    assert_int_equal(h.others, said);
    while (h.others == said) { /* and after that time it is heard again */
        send_message(flooder, "T_STATUS", SIZE);
        assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 10000000) >= 0);
    }
    close(flooder);
    close(other);
    close_receiver(&receiver);
}

/* Sends `count` and waits until `receiver` has read them: a mark of another comes behind them. */
static void say_all(ss_receiver *receiver, heard *h, int from, int count, int other)
{
    const int marks = h->other_marks;
    for (int i = 0; i < count; ++i) {
        send_message(from, "T_STATUS", SIZE);
    }
    send_message(other, "T_STATUS", MARK);
    while (h->other_marks == marks) {
        assert_true(ss_receiver_wait(receiver, -1, ss_clock_now_ns() + 60000000000) > 0);
    }
}

/* More than once had a place in the filter. */
TEST(many_who_say_too_much_are_muted_all)
{
    enum { MAY_SAY = 4, GROUPS = 3, GROUP_SIZE = 16, SAYS = 30, FLOOD = 20000 };
    heard h;
    int flooder[GROUPS * GROUP_SIZE];
    ss_receiver *receiver = open_strict(&h, MAY_SAY, NULL);
    const int other = sender_open(0);
    for (int i = 0; i < GROUPS * GROUP_SIZE; ++i) {
        flooder[i] = sender_open(0);
    }
    /* As many at once as the buffer takes; again, and for longer, where the first are let in before
     * the last are muted. */
    int64_t start_ns = 0;
    do {
        start_ns = ss_clock_now_ns();
        for (int g = 0; g < GROUPS; ++g) {
            for (int i = 0; i < SAYS * GROUP_SIZE; ++i) {
                send_message(flooder[g * GROUP_SIZE + i % GROUP_SIZE], "T_STATUS", SIZE);
            }
            const int newcomer = sender_open(0);
            say_all(receiver, &h, newcomer, 0, newcomer);
            close(newcomer);
        }
    } while (ss_clock_now_ns() - start_ns > 900000000);
    for (int i = 0; i < FLOOD; ++i) {
        send_message(flooder[i % (GROUPS * GROUP_SIZE)], "T_STATUS", SIZE);
    }
    say_all(receiver, &h, other, 0, other);
    for (int i = 0; i < GROUPS * GROUP_SIZE; ++i) {
        close(flooder[i]);
    }
    close(other);
    close_receiver(&receiver);
}

/* Whatever it says: without it the others are all that is left to hear. */
TEST(the_sender_that_is_followed_is_never_muted)
{
    enum { MAY_SAY = 4, SAYS = 100 };
    heard h;
    uint64_t followed = 0;
    ss_receiver *receiver = open_strict(&h, MAY_SAY, &followed);
    const int leader = sender_open(0), other = sender_open(0);
    say_all(receiver, &h, leader, 1, other);
    followed = h.source;
    say_all(receiver, &h, leader, SAYS, other);
    assert_int_equal(h.others, 1 + SAYS);
    close(leader);
    close(other);
    close_receiver(&receiver);
}

/* Says something now and then until it is told to stop. */
typedef struct talker {
    int fd;
    atomic_bool is_stopped;
} talker;

static void *talk(void *argument)
{
    talker *t = argument;
    while (!atomic_load(&t->is_stopped)) {
        const struct timespec pause = {.tv_nsec = 10000000};
        send_message(t->fd, "T_STATUS", SIZE);
        nanosleep(&pause, NULL);
    }
    return NULL;
}

/* With nobody else there is nothing that would end the wait sooner. */
TEST(a_wait_lets_the_muted_in_when_their_time_is_over)
{
    enum { MAY_SAY = 4 };
    heard h;
    ss_receiver *receiver = open_strict(&h, MAY_SAY, NULL);
    const int other = sender_open(0);
    talker t = {.fd = sender_open(0)};
    pthread_t thread;
    say_all(receiver, &h, t.fd, 10 * MAY_SAY, other);
    const int before = h.others;
    assert_int_equal(pthread_create(&thread, NULL, talk, &t), 0);
    const int32_t handled =
        ss_receiver_wait(receiver, -1, ss_clock_now_ns() + (int64_t)60000000000);
    atomic_store(&t.is_stopped, true);
    pthread_join(thread, NULL);
    assert_true(handled > 0);
    assert_true(h.others > before);
    close(t.fd);
    close(other);
    close_receiver(&receiver);
}

TEST(a_signal_is_not_kept_waiting_by_a_flood)
{
    heard h;
    ss_receiver *receiver = open_receiver(&h, NULL, "T");
    const int fd = sender_open(0), wake_fd = ss_wake_open();
    for (int i = 0; i < 500; ++i) {
        send_message(fd, "T_PROBE_0", SIZE);
    }
    for (int i = 0; i < 10; ++i) {
        ss_wake_signal(wake_fd);
        /* One batch at most; without the signal it would wait for a minute. */
        assert_in_range(ss_receiver_wait(receiver, wake_fd, ss_clock_now_ns() + 60000000000), 0,
                        32);
    }
    close(fd);
    close(wake_fd);
    close_receiver(&receiver);
}

/* ---- parsing ---- */

TEST(nothing_is_read_beyond_a_datagram)
{
    uint8_t datagram[512];
    ss_packet packet;
    const int whole = make(datagram, "LC02", "T_PROBE_5", 4);
    for (int size = 0; size <= whole; ++size) {
        uint8_t *copy = malloc(size > 0 ? (size_t)size : 1); /* for a sanitizer to watch */
        memcpy(copy, datagram, (size_t)size);
        const bool is_message = ss_receiver_parse(&lanes[0], "T", copy, size, &packet);
        assert_int_equal(is_message, size >= whole - 4);
        assert_true(!is_message || packet.size == size - (whole - 4));
        free(copy);
    }
    memset(datagram + 8, 'T', sizeof datagram - 8); /* a channel without an end */
    assert_false(ss_receiver_parse(&lanes[0], "T", datagram, sizeof datagram, &packet));
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
