/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A datagram passes when all of this holds, the first that fails drops it in the kernel, before it
 * costs one of our threads anything:
 *   local   IP TTL 0, and looped back by the kernel (packet type LOOPBACK: what this host sends to
 *           a group on any device) or arrived on a loopback device (hardware type LOOPBACK). Either
 *           alone does not do: the kernel does send TTL 0 out of a host on which nobody has joined
 *           the group, and a neighbour can write any TTL into a packet of its own, but only the
 *           receiving kernel gives the packet type.
 *   whole   LCM's magic of an unfragmented message, "LC02" (fragments begin with "LC03")
 *   channel exactly one of the names, with its NUL
 *   size    no longer than any good message: large ones would fill the socket's buffer with few,
 *           and what waits behind them would come late
 *   part    the message has it, or has it not: a message too short for it has it not
 *   heard   the sender is not muted: the longest question, so that it comes last
 * Layout, from the UDP header on: 8 bytes UDP; 4 magic; 4 sequence number; channel; NUL; message.
 * A load beyond the end of a datagram drops it.
 */
#include "net/filter.h"

#include <linux/filter.h>
#include <linux/if_arp.h>
#include <linux/if_packet.h>
#include <string.h>
#include <sys/socket.h>

enum {
    MAGIC_AT = 8,
    CHANNEL_AT = 16,
    IP_TTL_AT = 8,
    IP_SOURCE_AT = 12,
    PORT_AT = 0,
    OPEN = 255,
    /* A name of 63 bytes takes 41, a part 20 at most; a muted sender 5 where it is the only one of
     * its address. */
    MAX_CODE = 24 + SS_FILTER_MAX_NAMES * 64 + SS_FILTER_MAX_MUTED * 5
};
static const uint32_t WHOLE_MESSAGE = 0x4c433032; /* "LC02" */
static const uint32_t WHOLE = UINT32_MAX;         /* of a datagram that passes */

/* A program as it is written. */
typedef struct program {
    struct sock_filter code[MAX_CODE];
    uint16_t count;
} program;

static void load(program *p, uint16_t size, uint32_t at)
{
    p->code[p->count++] = (struct sock_filter)BPF_STMT((uint16_t)(BPF_LD | BPF_ABS | size), at);
}

/* Of the datagram, from the UDP header on. */
static void load_size(program *p)
{
    p->code[p->count++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_LEN, 0);
}

/* Jumps by `met` or `unmet` instructions; OPEN ones go where `land` will say. */
static void compare(program *p, uint16_t comparison, uint32_t value, uint8_t met, uint8_t unmet)
{
    p->code[p->count++] =
        (struct sock_filter)BPF_JUMP((uint16_t)(BPF_JMP | comparison | BPF_K), value, met, unmet);
}

/* Every open jump since `first` goes to the next instruction. */
static void land(program *p, uint16_t first)
{
    for (uint16_t i = first; i < p->count; ++i) {
        struct sock_filter *code = &p->code[i];
        const uint8_t way = (uint8_t)(p->count - i - 1);
        if (BPF_CLASS(code->code) == BPF_JMP) {
            code->jt = code->jt == OPEN ? way : code->jt;
            code->jf = code->jf == OPEN ? way : code->jf;
        }
    }
}

static void finish(program *p, uint32_t bytes_kept)
{
    p->code[p->count++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, bytes_kept);
}

static void demand_local(program *p)
{
    load(p, BPF_B, (uint32_t)(SKF_NET_OFF + IP_TTL_AT));
    compare(p, BPF_JEQ, 0, 0, OPEN);
    load(p, BPF_W, (uint32_t)(SKF_AD_OFF + SKF_AD_PKTTYPE));
    compare(p, BPF_JEQ, PACKET_LOOPBACK, 2, 0); /* over the question for the device */
    load(p, BPF_W, (uint32_t)(SKF_AD_OFF + SKF_AD_HATYPE));
    compare(p, BPF_JEQ, ARPHRD_LOOPBACK, 0, OPEN);
}

static uint32_t read_word(const unsigned char *byte)
{
    return (uint32_t)byte[0] << 24 | (uint32_t)byte[1] << 16 | (uint32_t)byte[2] << 8 | byte[3];
}

static void demand_bytes(program *p, uint32_t at, const void *bytes, uint32_t size)
{
    const unsigned char *byte = bytes;
    for (uint32_t i = 0; i < size; i += size - i >= 4 ? 4 : 1) {
        const bool is_word = size - i >= 4;
        load(p, is_word ? BPF_W : BPF_B, at + i);
        compare(p, BPF_JEQ, is_word ? read_word(byte + i) : byte[i], 0, OPEN);
    }
}

/* The channel is `name`, its NUL included. */
static void demand_name(program *p, const char *name)
{
    const uint32_t size = (uint32_t)strlen(name) + 1;
    for (uint32_t at = 0; at < size; ++at) {
        const char *digit = memchr(name + at, '#', size - at);
        const uint32_t plain = digit != NULL ? (uint32_t)(digit - name) - at : size - at;
        demand_bytes(p, CHANNEL_AT + at, name + at, plain);
        at += plain;
        if (digit != NULL) {
            load(p, BPF_B, CHANNEL_AT + at);
            compare(p, BPF_JGE, '0', 0, OPEN);
            compare(p, BPF_JGT, '7', OPEN, 0);
        }
    }
}

/* The message is one of ours: on to the senders, from wherever this is. */
static void go_to_senders(program *p)
{
    p->code[p->count++] = (struct sock_filter)BPF_STMT(BPF_JMP | BPF_JA, 0);
}

/* Behind a channel that fits: goes on when the message has the part, or has it not. */
static void judge_part(program *p, const ss_filter_part *part, uint32_t message_at)
{
    if (!part->is_unwanted) {
        demand_bytes(p, message_at + part->at, part->bytes, part->size);
        go_to_senders(p);
        return;
    }
    const uint16_t first = p->count;
    load_size(p);
    compare(p, BPF_JGE, message_at + part->at + part->size, 0, OPEN);
    demand_bytes(p, message_at + part->at, part->bytes, part->size);
    finish(p, 0);
    land(p, first);
    go_to_senders(p);
}

/* The first `count` are of one address, which is asked for once. */
static void refuse_senders_of(program *p, const uint64_t *muted, int32_t count)
{
    const uint16_t first = p->count;
    load(p, BPF_W, (uint32_t)(SKF_NET_OFF + IP_SOURCE_AT));
    compare(p, BPF_JEQ, (uint32_t)(muted[0] >> 16), 0, OPEN);
    load(p, BPF_H, PORT_AT);
    for (int32_t i = 0; i < count; ++i) {
        const int32_t to_end = count - 1 - i;
        compare(p, BPF_JEQ, (uint32_t)(muted[i] & 0xffff), (uint8_t)to_end, to_end == 0);
    }
    finish(p, 0);
    land(p, first);
}

static void judge_sender(program *p, const ss_filter *filter)
{
    for (uint16_t i = 0; i < p->count; ++i) {
        if (p->code[i].code == (BPF_JMP | BPF_JA)) {
            p->code[i].k = (uint32_t)(p->count - i - 1);
        }
    }
    for (int32_t i = 0, count = 0; i < filter->muted_count; i += count) {
        const uint64_t *muted = filter->muted + i;
        count = 1;
        while (i + count < filter->muted_count && muted[count] >> 16 == muted[0] >> 16) {
            ++count;
        }
        refuse_senders_of(p, muted, count);
    }
    finish(p, WHOLE);
}

bool ss_filter_attach(const ss_filter *filter, int fd)
{
    program p = {.count = 0};
    if (filter->is_local) {
        demand_local(&p);
    }
    load(&p, BPF_W, MAGIC_AT);
    compare(&p, BPF_JEQ, WHOLE_MESSAGE, 1, 0);
    land(&p, 0);
    finish(&p, 0); /* passed over when all holds so far */
    for (int32_t i = 0; i < filter->name_count; ++i) {
        const uint16_t first = p.count;
        const uint32_t message_at = CHANNEL_AT + (uint32_t)strlen(filter->names[i]) + 1;
        demand_name(&p, filter->names[i]);
        load_size(&p);
        compare(&p, BPF_JGT, message_at + filter->longest, OPEN, 0);
        judge_part(&p, &filter->part, message_at);
        land(&p, first);
    }
    finish(&p, 0);
    judge_sender(&p, filter);
    const struct sock_fprog attached = {.len = p.count, .filter = p.code};
    return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &attached, sizeof attached) == 0;
}
