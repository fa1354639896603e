/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A raw UDP flooder: hostile datagrams to an LCM group, with no LCM in between. Each kind is one
 * row of the table below. Only for a private network namespace or a machine of your own:
 *   flood KIND [--rate PACKETS_PER_S] [--burst N] [--sockets N] [--seconds S] [--ttl T]
 *         [--to ADDRESS] [--list]
 * Rate 0 is as fast as the kernel takes them. Packets go out in bursts, one a millisecond unless
 * --burst says how many at once, by each socket in turn: each is a sender of its own. --sockets 0:
 * every packet comes from a new one. Says at the end what it sent.
 */
#include <arpa/inet.h>
#include <getopt.h>
#include <math.h>
#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "common/pose_fixture.h"
#include "rt/random.h"
#include "softsim_command_t.h"
#include "softsim_contact_force_t.h"
#include "softsim_probe_pose_t.h"
#include "softsim_reply_t.h"
#include "softsim_server_status_t.h"

enum { MAX_PACKET = 65507, BIG = 60000, BATCH = 64, LISTEN_S = 10, MAX_SOCKETS = 512 };
static const char GROUP[] = "239.255.76.67";
static const uint16_t PORT = 7667;

/* One datagram as it is written. */
typedef struct packet {
    uint8_t byte[MAX_PACKET];
    int size;
} packet;

static uint32_t number; /* of the datagram, from 1 */
static int64_t holder;  /* the sender that holds probe 0, for pose-holder */
static uint64_t random_state = 1;

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

/* ---- pieces ---- */

static void put(packet *p, const void *bytes, size_t size)
{
    memcpy(p->byte + p->size, bytes, size);
    p->size += (int)size;
}

static void put_number(packet *p, uint64_t value, int bytes)
{
    for (int i = bytes - 1; i >= 0; --i) {
        p->byte[p->size++] = (uint8_t)(value >> 8 * i);
    }
}

static void put_zeros(packet *p, int count)
{
    memset(p->byte + p->size, 0, (size_t)count);
    p->size += count;
}

/* The head of a whole message. */
static void start(packet *p, const char *channel)
{
    p->size = 0;
    put(p, "LC02", 4);
    put_number(p, number, 4);
    put(p, channel, strlen(channel) + 1);
}

static int room(const packet *p)
{
    return MAX_PACKET - p->size;
}

static void start_fragment(packet *p, uint32_t size, uint32_t offset, uint32_t at, uint32_t count)
{
    p->size = 0;
    put(p, "LC03", 4);
    put_number(p, number, 4);
    put_number(p, size, 4);
    put_number(p, offset, 4);
    put_number(p, at, 2);
    put_number(p, count, 2);
}

/* ---- kinds ---- */

static softsim_probe_pose_t good_pose(int64_t sender, int32_t seq)
{
    return (softsim_probe_pose_t){.utime = now_ns() / 1000,
                                  .sender = sender,
                                  .seq = seq,
                                  .position = {0, 0, 0.3},
                                  PLAIN_POSE};
}

static void put_pose(packet *p, const char *channel, const softsim_probe_pose_t *pose)
{
    start(p, channel);
    p->size += softsim_probe_pose_t_encode(p->byte, p->size, room(p), pose);
}

static void pose_good(packet *p)
{
    const softsim_probe_pose_t pose = good_pose(0x5eed, (int32_t)number);
    put_pose(p, "SOFTSIM_PROBE_0", &pose);
}

static void pose_senders(packet *p)
{
    const softsim_probe_pose_t pose = good_pose((int64_t)ss_random_next(&random_state), 1);
    put_pose(p, "SOFTSIM_PROBE_0", &pose);
}

static void pose_holder(packet *p)
{
    const softsim_probe_pose_t pose = good_pose(holder, 1000000000 + (int32_t)number);
    put_pose(p, "SOFTSIM_PROBE_0", &pose);
}

static void pose_probe(packet *p)
{
    softsim_probe_pose_t pose = good_pose(0x5eed, (int32_t)number);
    pose.probe = 5;
    put_pose(p, "SOFTSIM_PROBE_5", &pose);
}

static void pose_nan(packet *p)
{
    softsim_probe_pose_t pose = good_pose(0x5eed, (int32_t)number);
    pose.position[1] = NAN;
    put_pose(p, "SOFTSIM_PROBE_0", &pose);
}

static void pose_hash(packet *p)
{
    pose_good(p);
    p->byte[24] ^= 0xff; /* 8 head, 16 channel */
}

/* A packet, in a line or two. */
#define BUILD(name, ...)                                                                           \
    static void name(packet *p)                                                                    \
    {                                                                                              \
        __VA_ARGS__;                                                                               \
    }

BUILD(pose_short, pose_good(p); p->size -= 1 + (int)(ss_random_next(&random_state) % 100))
BUILD(pose_long, pose_good(p); put_zeros(p, BIG))
BUILD(pose_empty, start(p, "SOFTSIM_PROBE_0"))

static void pose_random(packet *p)
{
    pose_good(p);
    for (int i = 32; i < p->size; ++i) {
        p->byte[i] = (uint8_t)ss_random_next(&random_state);
    }
}

static void put_command(packet *p, const char *name, const char *argument)
{
    const softsim_command_t command = {.utime = now_ns() / 1000,
                                       .sender = 0x5eed,
                                       .seq = (int32_t)number,
                                       .id = (int32_t)number,
                                       .name = (char *)name,
                                       .argument = (char *)argument};
    start(p, "SOFTSIM_COMMAND");
    p->size += softsim_command_t_encode(p->byte, p->size, room(p), &command);
}

BUILD(command_status, put_command(p, "status", ""))
BUILD(command_refresh, put_command(p, "refresh", ""))
BUILD(command_reset, put_command(p, "reset", ""))
BUILD(command_pause, put_command(p, number % 2 == 1 ? "pause" : "resume", ""))
BUILD(command_set,
      put_command(p, "set", number % 2 == 1 ? "haptic.max_force_n=1" : "haptic.max_force_n=8"))
BUILD(command_unknown, put_command(p, "dance", "tango"))

static void command_malformed(packet *p)
{
    command_status(p);
    p->byte[p->size - 13] = 0x7f; /* the length of its name */
}

BUILD(command_long, command_status(p); put_zeros(p, BIG))
BUILD(command_shutdown, put_command(p, "shutdown", ""))

static void put_status(packet *p, int cut)
{
    static char text[] = "flood";
    const softsim_server_status_t status = {.utime = now_ns() / 1000,
                                            .seq = (int32_t)number,
                                            .scene = text,
                                            .model = text,
                                            .reason = text};
    start(p, "SOFTSIM_STATUS");
    p->size += softsim_server_status_t_encode(p->byte, p->size, room(p), &status) - cut;
}

BUILD(status_good, put_status(p, 0))
BUILD(status_short, put_status(p, 20))

static void force_fake(packet *p)
{
    const softsim_contact_force_t force = {
        .utime = now_ns() / 1000, .sender = 0x5eed, .seq = (int32_t)number, .force = {0, 0, 8}};
    start(p, "SOFTSIM_FORCE_0");
    p->size += softsim_contact_force_t_encode(p->byte, p->size, room(p), &force);
}

static void reply_fake(packet *p)
{
    static char text[] = "done";
    const softsim_reply_t reply = {.sender = 0x5eed, .id = (int32_t)number, .text = text};
    start(p, "SOFTSIM_REPLY");
    p->size += softsim_reply_t_encode(p->byte, p->size, room(p), &reply);
}

BUILD(topology_fake, start(p, "SOFTSIM_MESH_TOPOLOGY"); put_zeros(p, BIG))
BUILD(delta_fake, start(p, "SOFTSIM_MESH_DELTA"); put_zeros(p, 1000))
BUILD(fragment_first, start_fragment(p, 100000, 0, 0, 2); put(p, "SOFTSIM_PROBE_0", 16);
      put_zeros(p, 1000))

BUILD(fragment_middle, start_fragment(p, 100000, 50000, 1, 3); put_zeros(p, 1000))
BUILD(fragment_many, start_fragment(p, 100000, 0, 0, 65535); put(p, "SOFTSIM_PROBE_0", 16);
      put_zeros(p, 100))

BUILD(fragment_huge, start_fragment(p, 1u << 28, 0, 0, 4000); put(p, "SOFTSIM_PROBE_0", 16);
      put_zeros(p, 100))

/* An offset that wraps in 32 bits when LCM adds the size. */
static void fragment_wrap(packet *p)
{
    /* LCM puts together only what somebody has subscribed to. */
    static const char *const channels[] = {"SOFTSIM_PROBE_0", "SOFTSIM_FORCE_0", "SOFTSIM_STATUS"};
    const char *channel = channels[number % 3];
    start_fragment(p, 100, 0xfffffff0u, 0, 1);
    put(p, channel, strlen(channel) + 1);
    put_zeros(p, 40);
}

BUILD(fragment_overlap, start_fragment(p, 2000, 500, 1, 4); put_zeros(p, 1400))
BUILD(magic_wrong, pose_good(p); p->byte[3] = '4')
BUILD(one_byte, p->size = 0; put(p, "L", 1))
BUILD(channel_empty, start(p, ""); put_zeros(p, 100))

static void channel_long(packet *p)
{
    p->size = 0;
    put(p, "LC02", 4);
    put_number(p, number, 4);
    memset(p->byte + p->size, 'S', 1000);
    p->size += 1000;
}

BUILD(channel_unknown, start(p, "ELSEWHERE_PROBE_0"); put_zeros(p, 148))
BUILD(self_test, start(p, "LCM_SELF_TEST"); put_zeros(p, 8))
BUILD(channel_near, start(p, "SOFTSIM_PROBE_8"); put_zeros(p, 148))

static const struct kind {
    const char *name;
    void (*make)(packet *p);
} kinds[] = {{"pose-good", pose_good},
             {"pose-senders", pose_senders},
             {"pose-holder", pose_holder},
             {"pose-probe", pose_probe},
             {"pose-nan", pose_nan},
             {"pose-hash", pose_hash},
             {"pose-short", pose_short},
             {"pose-long", pose_long},
             {"pose-empty", pose_empty},
             {"pose-random", pose_random},
             {"command-status", command_status},
             {"command-refresh", command_refresh},
             {"command-reset", command_reset},
             {"command-pause", command_pause},
             {"command-set", command_set},
             {"command-unknown", command_unknown},
             {"command-malformed", command_malformed},
             {"command-long", command_long},
             {"status", status_good},
             {"status-short", status_short},
             {"force", force_fake},
             {"reply", reply_fake},
             {"topology", topology_fake},
             {"delta", delta_fake},
             {"fragment-first", fragment_first},
             {"fragment-middle", fragment_middle},
             {"fragment-many", fragment_many},
             {"fragment-huge", fragment_huge},
             {"fragment-wrap", fragment_wrap},
             {"fragment-overlap", fragment_overlap},
             {"magic", magic_wrong},
             {"one-byte", one_byte},
             {"channel-empty", channel_empty},
             {"channel-long", channel_long},
             {"channel-unknown", channel_unknown},
             {"channel-near", channel_near},
             {"self-test", self_test},
             {"command-shutdown", command_shutdown}};
/* The last one, which ends all others, is not mixed with them. */
enum { KIND_COUNT = sizeof kinds / sizeof *kinds, MIXED_COUNT = KIND_COUNT - 1 };

/* ---- sending ---- */

/* Every force tells its holder's number. False after LISTEN_S without one. */
static bool hear_holder(void)
{
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    const int yes = 1;
    const struct timeval limit = {.tv_sec = LISTEN_S};
    const struct sockaddr_in here = {.sin_family = AF_INET, .sin_port = htons(PORT)};
    struct ip_mreq group = {.imr_multiaddr.s_addr = inet_addr(GROUP)};
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    if (bind(fd, (const struct sockaddr *)&here, sizeof here) != 0 ||
        setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0) {
        return false;
    }
    static const char channel[] = "SOFTSIM_FORCE_0";
    uint8_t data[2048];
    const int64_t end_ns = now_ns() + LISTEN_S * 1000000000LL;
    bool is_heard = false;
    while (!is_heard && now_ns() < end_ns) {
        const ssize_t size = recv(fd, data, sizeof data, 0);
        is_heard = size > 48 && memcmp(data + 8, channel, sizeof channel) == 0;
    }
    holder = 0;
    for (int i = 0; is_heard && i < 8; ++i) { /* behind head, channel, type hash and utime */
        holder = (int64_t)((uint64_t)holder << 8 | data[8 + sizeof channel + 16 + (size_t)i]);
    }
    close(fd);
    return is_heard;
}

typedef struct flood_plan {
    const char *kind;
    double rate, seconds;
    int burst, ttl, sockets;
    struct sockaddr_in to;
} flood_plan;

/* -1 with a message. */
static int open_sender(const flood_plan *plan)
{
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (fd < 0 || setsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &plan->ttl, sizeof plan->ttl) != 0) {
        perror("flood");
        return -1;
    }
    return fd;
}

/* Makes and sends `count` datagrams of the kind, "mixed": of all in turn. How many went out. */
static int64_t send_some(const int fd[], const flood_plan *plan, int kind, int count)
{
    static packet p;
    int64_t sent = 0;
    for (int i = 0; i < count; ++i) {
        ++number;
        kinds[kind < KIND_COUNT ? kind : (int)(number % MIXED_COUNT)].make(&p);
        const bool is_new = plan->sockets == 0;
        const int from = is_new ? open_sender(plan) : fd[number % (uint32_t)plan->sockets];
        sent += sendto(from, p.byte, (size_t)p.size, 0, (const struct sockaddr *)&plan->to,
                       sizeof plan->to) == p.size;
        if (is_new) {
            close(from);
        }
    }
    return sent;
}

static int flood(const flood_plan *plan, int kind)
{
    int fd[MAX_SOCKETS];
    const int64_t start_ns = now_ns();
    const int64_t end_ns = start_ns + (int64_t)(plan->seconds * 1e9);
    int64_t sent = 0;
    for (int i = 0; i < plan->sockets; ++i) {
        fd[i] = open_sender(plan);
        if (fd[i] < 0) {
            return 1;
        }
    }
    int burst = plan->burst;
    if (burst == 0) {
        burst = plan->rate > 1000.0 ? (int)(plan->rate / 1000.0) : 1;
    }
    for (int64_t n = 0; now_ns() < end_ns; ++n) {
        if (plan->rate > 0.0) {
            const int64_t due_ns = start_ns + (int64_t)(1e9 * (double)(n * burst) / plan->rate);
            const struct timespec due = {.tv_sec = due_ns / 1000000000,
                                         .tv_nsec = due_ns % 1000000000};
            clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL);
        }
        sent += send_some(fd, plan, kind, burst);
    }
    const double took_s = 1e-9 * (double)(now_ns() - start_ns);
    printf("flood: %s: %lld packets, %.0f a second\n", plan->kind, (long long)sent,
           (double)sent / took_s);
    for (int i = 0; i < plan->sockets; ++i) {
        close(fd[i]);
    }
    return 0;
}

static int usage(void)
{
    fprintf(stderr, "flood: flood KIND|mixed [--rate N] [--burst N] [--sockets N] [--seconds S] "
                    "[--ttl T] [--to ADDRESS]; kinds: flood --list\n");
    return 2;
}

int main(int argc, char **argv)
{
    static const struct option options[] = {
        {"rate", required_argument, NULL, 'r'},    {"burst", required_argument, NULL, 'b'},
        {"sockets", required_argument, NULL, 'n'}, {"seconds", required_argument, NULL, 's'},
        {"ttl", required_argument, NULL, 't'},     {"to", required_argument, NULL, 'a'},
        {"list", no_argument, NULL, 'l'},          {NULL, 0, NULL, 0}};
    flood_plan plan = {.rate = 1000.0, .seconds = 1.0, .sockets = 1};
    const char *to = GROUP;
    for (int c = 0; (c = getopt_long(argc, argv, "", options, NULL)) != -1;) {
        switch (c) {
        case 'r':
            plan.rate = atof(optarg);
            break;
        case 'b':
            plan.burst = atoi(optarg);
            break;
        case 'n':
            plan.sockets = atoi(optarg);
            break;
        case 's':
            plan.seconds = fmin(atof(optarg), 600.0);
            break;
        case 't':
            plan.ttl = atoi(optarg);
            break;
        case 'a':
            to = optarg;
            break;
        case 'l':
            for (int i = 0; i < KIND_COUNT; ++i) {
                puts(kinds[i].name);
            }
            return 0;
        default:
            return usage();
        }
    }
    plan.to = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons(PORT)};
    plan.kind = optind < argc ? argv[optind] : "";
    int kind = 0;
    while (kind < KIND_COUNT && strcmp(kinds[kind].name, plan.kind) != 0) {
        ++kind;
    }
    if ((kind == KIND_COUNT && strcmp(plan.kind, "mixed") != 0) ||
        inet_pton(AF_INET, to, &plan.to.sin_addr) != 1 || plan.burst < 0 || plan.rate < 0.0 ||
        plan.sockets < 0 || plan.sockets > MAX_SOCKETS) {
        return usage();
    }
    if (strcmp(plan.kind, "pose-holder") == 0 && !hear_holder()) {
        fprintf(stderr, "flood: no force came that tells a holder\n");
        return 1;
    }
    return flood(&plan, kind);
}
