/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * LCM's own receive path is not safe on an open network. Its reader starts at once, on a bound
 * socket of which nobody else gets hold; it puts fragments together with
 *   if (fragment_offset + fragment_size > message_size) refuse
 * in 32 bits, so that one datagram with an offset near 2^32 makes it write 4 GB behind its buffer;
 * it takes what is sent to the host as well as to the group; it reads as fast as anybody sends, at
 * the priority of our net thread; and it does not say who sent. So we send by LCM and receive here:
 *
 *   socket, filter (filter.c), bind to the group, join
 *
 * in this order: before the bind nothing can be queued, and after it nothing that the filter has
 * not passed. Bound to the group's address, the socket gets nothing that was sent to the host. All
 * our messages fit one datagram (wire.h), so fragments are not for us at all.
 *
 * A lane is one socket with its channels, or with the part of a channel whose messages say the same
 * at one place, and a budget of work, in units of about 1.5 us: a wake-up with its read is
 * READ_COST of them, a message one, and one more for every BYTES_COST bytes. Light traffic is read
 * as it comes. Dense traffic spends the budget on wake-ups, and is then left until there is enough
 * for a whole batch at the price of one wake-up; what comes faster than that fills the kernel's
 * buffer of some hundred messages and is dropped there, at no cost to our threads. A pose thus
 * waits a few milliseconds at most in the worst flood.
 *
 * A budget keeps our threads, not the others who send: their messages find the buffer full. So
 * where a lane says how much one sender may send, who sends more is muted: the filter drops what
 * comes from its address and port, for a second. It then starts with nothing: who goes on is muted
 * again at once, for longer, and who has become slow is heard. All together may send
 * half of what the lane can read, in fair shares (senders.h), so that many who each send little are
 * muted too before they fill the buffer. The sender that a lane follows is never muted.
 *
 * Alternatives rejected: a socket for each sender, which nobody knows before it has spoken; reading
 * all there is and dropping it here, which a flood of one core pays with another; LCM with `bind`
 * interposed to attach the filter, which cures fragments but neither the unbounded reading nor the
 * missing sender address, and works only where liblcm is linked dynamically; a filter attached
 * after lcm_subscribe, which leaves the milliseconds of LCM's self test open: at 20,000 fragments a
 * second 18 of 30 servers died in them.
 *
 * memq:// (one process, for tests) still comes through LCM, and has no budget.
 */
#include "net/receiver.h"

#include <arpa/inet.h>
#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include "net/senders.h"
#include "net/wire.h"
#include "rt/budget.h"
#include "rt/clock.h"
#include "rt/files.h"
#include "rt/memory.h"
#include "rt/thread.h"

enum {
    BATCH = 32,            /* messages a system call */
    MAX_HANDLED = 4096,    /* a call of ss_receiver_wait, so that it returns */
    HEADER_SIZE = 8,       /* magic, sequence number */
    MAX_CHANNEL = 64,      /* its NUL included */
    STOCK_BUFFER = 212992, /* bytes, the kernel's default limit; some hundred small messages */
    READ_COST = 4,
    BYTES_COST = 1024,
    MUTINGS_PER_S = 50, /* new filters: one takes 30 to 60 us, 0.5 ms with many hosts in it */
    MUTINGS_BURST = 4,
    TEST_TRIES = 100
};
static const int64_t NS_PER_MS = 1000000;
static const int64_t NS_PER_S = 1000000000;
static const int64_t TEST_WAIT_NS = 100000000; /* ten seconds in all, as LCM's own */
/* Whoever goes on is muted for twice as long each time, and is let in alone: the buffer holds what
 * is read in 0.15 s, so that many who are let in every second, or together, would keep it full. */
static const int64_t MUTE_NS = 1000000000, MAX_MUTE_NS = 8000000000;
static const char TEST_CHANNEL[] = "LCM_SELF_TEST"; /* LCM's, so that spies know it */

typedef struct muted_sender {
    uint64_t source;
    int64_t until_ns, pause_ns;
    bool is_muted; /* until then at least */
} muted_sender;

typedef struct lane_state {
    ss_lane lane;
    ss_receiver *receiver;
    int fd; /* -1 in memq:// */
    ss_budget budget;
    bool is_spent; /* until there is enough for a batch */
    ss_filter filter;
    char name[SS_FILTER_MAX_NAMES][SS_WIRE_CHANNEL_SIZE];
    const char *names[SS_FILTER_MAX_NAMES];
    ss_senders senders;
    muted_sender muted[SS_FILTER_MAX_MUTED];
    ss_budget mutings;
    int64_t muting_ns; /* when the filter is to change; INT64_MAX: it is as it should be */
} lane_state;

struct ss_receiver {
    lcm_t *lcm; /* borrowed */
    char prefix[SS_WIRE_MAX_PREFIX + 1];
    void *context;
    bool is_memq;
    lane_state lane[SS_RECEIVER_MAX_LANES];
    int32_t lane_count;
    /* scratch: one batch */
    int32_t slot_size;
    uint8_t *slots;
    struct mmsghdr header[BATCH];
    struct iovec vector[BATCH];
    struct sockaddr_in source[BATCH];
};

/* ---- a datagram ---- */

/* Which name of the lane, or -1. */
static int32_t find_name(const ss_lane *lane, const char *prefix, const char *channel,
                         int32_t *out_digit)
{
    const size_t prefix_length = strlen(prefix);
    *out_digit = -1;
    if (strncmp(channel, prefix, prefix_length) != 0) {
        return -1;
    }
    const char *rest = channel + prefix_length;
    for (int32_t i = 0; i < SS_FILTER_MAX_NAMES && lane->suffix[i] != NULL; ++i) {
        const size_t plain = strcspn(lane->suffix[i], "#");
        const bool has_digit = lane->suffix[i][plain] == '#';
        if (strncmp(rest, lane->suffix[i], plain) != 0) {
            continue;
        }
        if (!has_digit && rest[plain] == '\0') {
            return i;
        }
        if (has_digit && rest[plain] >= '0' && rest[plain] <= '7' && rest[plain + 1] == '\0') {
            *out_digit = rest[plain] - '0';
            return i;
        }
    }
    return -1;
}

/* Has the message what its lane asks for? As the filter has it, for messages that bypass the kernel
 * filter. */
static bool matches_filter(const ss_lane *lane, const ss_packet *packet)
{
    const ss_filter_part *part = &lane->part;
    const bool has_part =
        packet->size >= 0 && (uint32_t)packet->size >= part->at + part->size &&
        (part->size == 0 || memcmp(packet->data + part->at, part->bytes, part->size) == 0);
    return has_part != part->is_unwanted;
}

bool ss_receiver_parse(const ss_lane *lane, const char *prefix, const uint8_t *datagram,
                       int32_t size, ss_packet *out_packet)
{
    if (size <= HEADER_SIZE || memcmp(datagram, "LC02", 4) != 0) {
        return false;
    }
    const char *channel = (const char *)datagram + HEADER_SIZE;
    const size_t room = (size_t)(size - HEADER_SIZE);
    const size_t length = strnlen(channel, room < MAX_CHANNEL ? room : MAX_CHANNEL);
    if (length == room || length == MAX_CHANNEL) {
        return false;
    }
    *out_packet = (ss_packet){.channel = channel,
                              .data = datagram + HEADER_SIZE + length + 1,
                              .size = size - HEADER_SIZE - (int32_t)length - 1};
    out_packet->name = find_name(lane, prefix, channel, &out_packet->digit);
    return out_packet->name >= 0 && matches_filter(lane, out_packet);
}

/* ---- reading ---- */

static uint64_t number_source(const struct sockaddr_in *source)
{
    return (uint64_t)ntohl(source->sin_addr.s_addr) << 16 | ntohs(source->sin_port);
}

/* Lets in the one whose time was over first. */
static void unmute_one(lane_state *lane, int64_t now_ns)
{
    muted_sender *first = NULL;
    for (int32_t i = 0; i < SS_FILTER_MAX_MUTED; ++i) {
        muted_sender *muted = &lane->muted[i];
        if (muted->is_muted && muted->until_ns <= now_ns &&
            (first == NULL || muted->until_ns < first->until_ns)) {
            first = muted;
        }
    }
    if (first != NULL) {
        first->is_muted = false;
    }
}

/* The filter is given all who are muted, in order. A kernel that refuses it leaves the one before.
 */
static void change_filter(lane_state *lane, int64_t now_ns)
{
    ss_filter *filter = &lane->filter;
    filter->muted_count = 0;
    lane->muting_ns = INT64_MAX;
    unmute_one(lane, now_ns);
    for (int32_t i = 0; i < SS_FILTER_MAX_MUTED; ++i) {
        const muted_sender *muted = &lane->muted[i];
        if (muted->is_muted) {
            int32_t place = filter->muted_count++;
            for (; place > 0 && filter->muted[place - 1] > muted->source; --place) {
                filter->muted[place] = filter->muted[place - 1];
            }
            filter->muted[place] = muted->source;
            lane->muting_ns = muted->until_ns < lane->muting_ns ? muted->until_ns : lane->muting_ns;
        }
    }
    (void)ss_filter_attach(filter, lane->fd);
    ss_budget_spend(&lane->mutings, 1);
}

/* At once, or as soon as there may be another filter. */
static void mute_when_due(lane_state *lane, int64_t now_ns)
{
    if (now_ns >= lane->muting_ns) {
        if (ss_budget_left(&lane->mutings, now_ns) >= 1) {
            change_filter(lane, now_ns);
        } else {
            lane->muting_ns = ss_budget_when(&lane->mutings, 1);
        }
    }
}

/* From now on for a time. Where it is muted already, what came was in the buffer before; where too
 * many are, it is not. */
static void mute(lane_state *lane, uint64_t source, int64_t now_ns)
{
    muted_sender *place = NULL;
    int64_t pause_ns = MUTE_NS;
    for (int32_t i = 0; i < SS_FILTER_MAX_MUTED; ++i) {
        muted_sender *muted = &lane->muted[i];
        if (muted->source == source) {
            place = muted;
            if (now_ns - muted->until_ns < MUTE_NS) {
                pause_ns = 2 * muted->pause_ns < MAX_MUTE_NS ? 2 * muted->pause_ns : MAX_MUTE_NS;
            }
            break;
        }
        if (!muted->is_muted && (place == NULL || muted->until_ns < place->until_ns)) {
            place = muted;
        }
    }
    if (place != NULL && !place->is_muted) {
        *place = (muted_sender){.source = source,
                                .until_ns = now_ns + pause_ns,
                                .pause_ns = pause_ns,
                                .is_muted = true};
        ss_senders_pause(&lane->senders, source, pause_ns);
        lane->muting_ns = now_ns;
        mute_when_due(lane, now_ns);
    }
}

/* May this sender say more in this lane? */
static bool is_within_rate(lane_state *lane, uint64_t source, int64_t now_ns)
{
    const ss_lane *limits = &lane->lane;
    if (limits->sender_per_s == 0 || (limits->followed != NULL && *limits->followed == source)) {
        return true;
    }
    const ss_senders_answer answer = ss_senders_hear(&lane->senders, source, now_ns);
    if (answer == SS_SENDERS_OVER) {
        mute(lane, source, now_ns);
    }
    return answer == SS_SENDERS_HEARD;
}

/* Hands over what is there, at most a batch. How many; -1 when the socket is broken. Fewer than it
 * has room for is all. */
static int32_t read_lane(ss_receiver *receiver, lane_state *lane, bool *is_all)
{
    const int64_t now_ns = ss_clock_now_ns();
    const int64_t left = ss_budget_left(&lane->budget, now_ns) - READ_COST;
    const unsigned wanted = left < BATCH ? (unsigned)left : BATCH;
    for (unsigned i = 0; i < wanted; ++i) {
        receiver->header[i].msg_hdr.msg_namelen = sizeof receiver->source[i];
    }
    ss_budget_spend(&lane->budget, READ_COST);
    const int count = recvmmsg(lane->fd, receiver->header, wanted, MSG_DONTWAIT, NULL);
    if (count < 0) {
        return errno == EAGAIN || errno == EINTR ? 0 : -1;
    }
    *is_all = *is_all && (unsigned)count < wanted;
    for (int i = 0; i < count; ++i) {
        ss_packet packet;
        const int32_t size = (int32_t)receiver->header[i].msg_len;
        ss_budget_spend(&lane->budget, 1 + size / BYTES_COST);
        if (ss_receiver_parse(&lane->lane, receiver->prefix, receiver->vector[i].iov_base, size,
                              &packet)) {
            packet.source = number_source(&receiver->source[i]);
            if (is_within_rate(lane, packet.source, now_ns)) {
                lane->lane.receive(receiver->context, &packet);
            }
        }
    }
    return count;
}

/* LCM hands over one message and would block without one. */
static int32_t read_memq(ss_receiver *receiver, bool *is_all)
{
    *is_all = false;
    return lcm_handle(receiver->lcm) == 0 ? 1 : -1;
}

static void receive_memq(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    lane_state *lane = user;
    ss_packet packet = {
        .channel = channel, .data = buffer->data, .size = (int32_t)buffer->data_size};
    packet.name = find_name(&lane->lane, lane->receiver->prefix, channel, &packet.digit);
    if (packet.name >= 0 && matches_filter(&lane->lane, &packet)) {
        lane->lane.receive(lane->receiver->context, &packet);
    }
}

/* When the lane is to be read again: one that has spent its budget waits for that of a whole batch,
 * however often others wake us up. INT64_MIN: it has not. */
static int64_t next_reading(lane_state *lane, int64_t now_ns)
{
    const int64_t whole = READ_COST + BATCH;
    const int64_t batch = lane->budget.burst < whole ? lane->budget.burst : whole;
    const int64_t left = ss_budget_left(&lane->budget, now_ns);
    lane->is_spent = left <= READ_COST || (lane->is_spent && left < batch);
    return lane->is_spent ? ss_budget_when(&lane->budget, batch) : INT64_MIN;
}

/* What to wait for, and until when; who is muted is let in again in time. */
static int64_t next_wakeup(ss_receiver *receiver, int64_t now_ns, int64_t limit_ns,
                           struct pollfd waiting[])
{
    for (int32_t i = 0; i < receiver->lane_count; ++i) {
        lane_state *lane = &receiver->lane[i];
        mute_when_due(lane, now_ns);
        const int64_t again_ns = receiver->is_memq ? INT64_MIN : next_reading(lane, now_ns);
        const bool is_open = again_ns == INT64_MIN;
        /* poll passes over a negative descriptor. */
        waiting[i] = (struct pollfd){.fd = is_open ? lane->fd : -1, .events = POLLIN};
        limit_ns = !is_open && again_ns < limit_ns ? again_ns : limit_ns;
        limit_ns = lane->muting_ns < limit_ns ? lane->muting_ns : limit_ns;
    }
    return limit_ns;
}

/* 1 something is there, 0 nothing until then or a signal to the process, -1 broken. */
static int wait_until(struct pollfd waiting[], nfds_t count, int64_t until_ns)
{
    const int64_t left_ns = until_ns - ss_clock_now_ns();
    const int64_t rest_ns = left_ns > 0 ? left_ns : 0;
    const struct timespec timeout = {.tv_sec = (time_t)(rest_ns / NS_PER_S),
                                     .tv_nsec = (long)(rest_ns % NS_PER_S)};
    const int result = ppoll(waiting, count, &timeout, NULL);
    if (result < 0) {
        return errno == EINTR ? 0 : -1;
    }
    for (nfds_t i = 0; i < count; ++i) {
        if ((waiting[i].revents & (POLLHUP | POLLNVAL)) != 0) {
            return -1;
        }
    }
    return result > 0;
}

/* A batch of every lane that has something. How many messages; -1 when a socket is broken. Where
 * that was all there was, nobody need look at the sockets again, which costs as much as reading. */
static int32_t read_ready(ss_receiver *receiver, const struct pollfd waiting[], bool *out_is_all)
{
    int32_t handled = 0;
    *out_is_all = true;
    for (int32_t i = 0; i < receiver->lane_count; ++i) {
        if (waiting[i].revents == 0) {
            continue;
        }
        const int32_t count = receiver->is_memq
                                  ? read_memq(receiver, out_is_all)
                                  : read_lane(receiver, &receiver->lane[i], out_is_all);
        if (count < 0) {
            return -1;
        }
        handled += count;
    }
    return handled;
}

int32_t ss_receiver_wait(ss_receiver *receiver, int wake_fd, int64_t deadline_ns)
{
    struct pollfd waiting[SS_RECEIVER_MAX_LANES + 1];
    const nfds_t lanes = (nfds_t)receiver->lane_count;
    int32_t handled = 0;
    bool is_signalled = false, is_all = false;
    while (handled < MAX_HANDLED && !is_signalled && !(is_all && handled > 0)) {
        const int64_t now_ns = ss_clock_now_ns();
        const int64_t limit_ns = handled > 0 ? now_ns : deadline_ns;
        const int64_t until_ns = next_wakeup(receiver, now_ns, limit_ns, waiting);
        waiting[lanes] = (struct pollfd){.fd = wake_fd, .events = POLLIN};
        const int ready = wait_until(waiting, lanes + 1, until_ns);
        if (ready < 0 || (ready == 0 && (until_ns >= limit_ns || handled > 0))) {
            return ready < 0 ? -1 : handled;
        }
        if (waiting[lanes].revents != 0) {
            if (handled > 0) {
                return handled;
            }
            ss_wake_drain(wake_fd);
            is_signalled = true;
        }
        const int32_t count = read_ready(receiver, waiting, &is_all);
        if (count < 0) {
            return -1;
        }
        handled += count;
    }
    return handled;
}

/* ---- opening ---- */

/* An unbound socket has nothing in it: the filter comes first. -1 with errno. */
static int open_socket(const ss_wire_url *url, const ss_filter *filter, int buffer)
{
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int yes = 1;
    const struct ip_mreq group = {.imr_multiaddr = url->group.sin_addr,
                                  .imr_interface.s_addr = htonl(INADDR_ANY)};
    if (fd < 0) {
        return -1;
    }
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
    if (!ss_filter_attach(filter, fd) ||
        setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        bind(fd, (const struct sockaddr *)&url->group, sizeof url->group) != 0 ||
        setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0) {
        const int reason = errno;
        close(fd);
        errno = reason;
        return -1;
    }
    return fd;
}

static softsim_status fail_socket(softsim_error *error)
{
    softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                      "cannot join the multicast group: %s; another program may hold the port "
                      "for itself, or the system forbids packet filters (SO_ATTACH_FILTER)",
                      ss_files_reason(errno));
    return SOFTSIM_ERROR_NETWORK;
}

/* Sends a number until something comes back: the filter lets nothing else in. */
static bool hears_itself(lcm_t *lcm, int fd, uint64_t number)
{
    struct pollfd waiting = {.fd = fd, .events = POLLIN};
    bool is_heard = false;
    for (int i = 0; i < TEST_TRIES && !is_heard; ++i) {
        const int64_t until_ns = ss_clock_now_ns() + TEST_WAIT_NS;
        lcm_publish(lcm, TEST_CHANNEL, &number, sizeof number);
        is_heard = wait_until(&waiting, 1, until_ns) > 0;
    }
    return is_heard;
}

/* The number is asked for in the kernel, so that others who test, or flood, cost nothing and fill
 * no buffer. */
static softsim_status test_group(const ss_receiver *receiver, const ss_wire_url *url,
                                 softsim_error *error)
{
    const char *const name = TEST_CHANNEL;
    uint64_t number = 0;
    if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number) {
        number = (uint64_t)ss_clock_now_ns();
    }
    const ss_filter filter = {.is_local = url->ttl == 0,
                              .names = &name,
                              .name_count = 1,
                              .part = {.bytes = &number, .size = sizeof number},
                              .longest = sizeof number};
    const int fd = open_socket(url, &filter, STOCK_BUFFER);
    if (fd < 0) {
        return fail_socket(error);
    }
    const bool is_heard = hears_itself(receiver->lcm, fd, number);
    close(fd);
    if (!is_heard) {
        char address[INET_ADDRSTRLEN] = "";
        inet_ntop(AF_INET, &url->group.sin_addr, address, sizeof address);
        softsim_error_add(error, SOFTSIM_ERROR_NETWORK,
                          "LCM hears none of its own packets: a firewall drops multicast; allow "
                          "UDP to %s port %d, or give another --lcm-url",
                          address, ntohs(url->group.sin_port));
        return SOFTSIM_ERROR_NETWORK;
    }
    return SOFTSIM_OK;
}

static softsim_status open_lane(ss_receiver *receiver, lane_state *lane, const ss_wire_url *url,
                                softsim_error *error)
{
    ss_filter *filter = &lane->filter;
    *filter = (ss_filter){.is_local = url->ttl == 0,
                          .names = lane->names,
                          .part = lane->lane.part,
                          .longest = (uint32_t)lane->lane.max_size};
    for (int32_t i = 0; i < SS_FILTER_MAX_NAMES && lane->lane.suffix[i]; ++i) {
        lane->names[i] = lane->name[i];
        snprintf(lane->name[i], sizeof lane->name[i], "%s%s", receiver->prefix,
                 lane->lane.suffix[i]);
        ++filter->name_count;
    }
    lane->fd = open_socket(url, filter, url->buffer > 0 ? url->buffer : lane->lane.buffer);
    return lane->fd >= 0 ? SOFTSIM_OK : fail_socket(error);
}

/* LCM reads a channel to subscribe to as a regular expression; of our characters only the dot
 * means something in one. */
static softsim_status subscribe_memq(ss_receiver *receiver, lane_state *lane)
{
    for (int32_t i = 0; i < SS_FILTER_MAX_NAMES && lane->lane.suffix[i] != NULL; ++i) {
        char name[SS_WIRE_CHANNEL_SIZE], regex[6 * SS_WIRE_CHANNEL_SIZE];
        size_t length = 0;
        snprintf(name, sizeof name, "%s%s", receiver->prefix, lane->lane.suffix[i]);
        for (const char *at = name; *at != '\0'; ++at) {
            const char *form = *at == '#' ? "[0-7]" : *at == '.' ? "\\." : NULL;
            length += (size_t)snprintf(regex + length, sizeof regex - length, "%.*s",
                                       form != NULL ? 5 : 1, form != NULL ? form : at);
        }
        if (lcm_subscribe(receiver->lcm, regex, receive_memq, lane) == NULL) {
            return SOFTSIM_ERROR_MEMORY;
        }
    }
    return SOFTSIM_OK;
}

static void prepare_batch(ss_receiver *receiver)
{
    for (int32_t i = 0; i < BATCH; ++i) {
        receiver->vector[i] =
            (struct iovec){.iov_base = receiver->slots + (size_t)i * (size_t)receiver->slot_size,
                           .iov_len = (size_t)receiver->slot_size};
        receiver->header[i].msg_hdr = (struct msghdr){
            .msg_name = &receiver->source[i], .msg_iov = &receiver->vector[i], .msg_iovlen = 1};
    }
}

static softsim_status open_lanes(ss_receiver *receiver, const ss_receiver_config *config,
                                 const ss_wire_url *url, softsim_error *error)
{
    softsim_status status = url->is_memq ? SOFTSIM_OK : test_group(receiver, url, error);
    receiver->lane_count = url->is_memq ? 1 : config->lane_count; /* of those that are waited for */
    for (int32_t i = 0; i < config->lane_count && status == SOFTSIM_OK; ++i) {
        lane_state *lane = &receiver->lane[i];
        lane->lane = config->lane[i];
        lane->receiver = receiver;
        lane->budget =
            (ss_budget){.interval_ns = NS_PER_MS / lane->lane.per_ms, .burst = lane->lane.burst};
        lane->mutings =
            (ss_budget){.interval_ns = NS_PER_S / MUTINGS_PER_S, .burst = MUTINGS_BURST};
        lane->muting_ns = INT64_MAX;
        const int32_t read_per_s = lane->lane.per_ms * 1000 / (READ_COST + BATCH) * BATCH;
        lane->senders = ss_senders_make(lane->lane.sender_per_s, read_per_s / 2);
        status =
            url->is_memq ? subscribe_memq(receiver, lane) : open_lane(receiver, lane, url, error);
        lane->fd = url->is_memq ? lcm_get_fileno(config->lcm) : lane->fd;
    }
    return status;
}

softsim_status ss_receiver_open(const ss_receiver_config *config, ss_receiver **out_receiver,
                                softsim_error *error)
{
    ss_wire_url url;
    *out_receiver = NULL;
    if (!ss_wire_read_url(config->lcm_url, &url, error)) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    ss_receiver *receiver = ss_memory_get(1, sizeof *receiver);
    if (receiver == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    receiver->lcm = config->lcm;
    receiver->context = config->context;
    receiver->is_memq = url.is_memq;
    snprintf(receiver->prefix, sizeof receiver->prefix, "%s", config->prefix);
    receiver->slot_size = HEADER_SIZE + MAX_CHANNEL;
    for (int32_t i = 0; i < SS_RECEIVER_MAX_LANES; ++i) {
        receiver->lane[i].fd = -1;
    }
    for (int32_t i = 0; i < config->lane_count; ++i) {
        const int32_t size = HEADER_SIZE + MAX_CHANNEL + config->lane[i].max_size;
        receiver->slot_size = size > receiver->slot_size ? size : receiver->slot_size;
    }
    receiver->slots = ss_memory_get(BATCH, (size_t)receiver->slot_size);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (receiver->slots != NULL) {
        prepare_batch(receiver);
        status = open_lanes(receiver, config, &url, error);
    }
    if (status == SOFTSIM_ERROR_MEMORY) {
        status = ss_memory_fault(error);
    }
    if (status != SOFTSIM_OK) {
        ss_receiver_close(&receiver);
        return status;
    }
    *out_receiver = receiver;
    return SOFTSIM_OK;
}

void ss_receiver_close(ss_receiver **receiver)
{
    if (*receiver == NULL) {
        return;
    }
    for (int32_t i = 0; i < SS_RECEIVER_MAX_LANES && !(*receiver)->is_memq; ++i) {
        if ((*receiver)->lane[i].fd >= 0) {
            close((*receiver)->lane[i].fd);
        }
    }
    ss_memory_free((*receiver)->slots);
    ss_memory_free(*receiver);
    *receiver = NULL;
}
