/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * LCM (1.3.1 up to 1.5) puts the pieces of a fragmented message together with
 *   if (fragment_offset + fragment_size > message_size) refuse
 * in 32 bits: an offset near 2^32 wraps, and one small datagram makes the receive thread write 4 GB
 * behind its buffer. It also allocates up to 256 MB for what a first fragment announces. Nothing of
 * ours is larger than one datagram, so a filter in the kernel lets in only datagrams that begin
 * with the magic of a whole message. LCM does not give its socket away (lcm_get_fileno is a pipe):
 * it is the bound UDP socket that appeared with the first subscription; sockets of the host
 * program are left alone. Between LCM's own bind and the filter lie the milliseconds of its self
 * test.
 * Rejected: checking in our handlers, which run after the damage; a receiver of our own, which
 * would be a second LCM.
 */
#include "rt/packets.h"

#include <fcntl.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>

enum { UDP_HEADER = 8 }; /* bytes: a filter sees the datagram from there on */
static const uint32_t WHOLE_MESSAGE = 0x4c433032; /* "LC02"; fragments begin with "LC03" */

void ss_packets_remember(ss_packets_mark *out_mark)
{
    for (int fd = 0; fd < SS_PACKETS_MAX_FD; ++fd) {
        out_mark->is_open[fd] = fcntl(fd, F_GETFD) != -1;
    }
}

static bool is_bound_udp(int fd)
{
    int type = 0;
    socklen_t size = sizeof type;
    struct sockaddr_in address = {0};
    socklen_t address_size = sizeof address;
    return getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_DGRAM &&
           getsockname(fd, (struct sockaddr *)&address, &address_size) == 0 &&
           address.sin_family == AF_INET && address.sin_port != 0;
}

int ss_packets_refuse_fragments(const ss_packets_mark *mark)
{
    /* A datagram too short to load from is refused by the load itself. */
    struct sock_filter code[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, UDP_HEADER),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, WHOLE_MESSAGE, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, UINT32_MAX),
        BPF_STMT(BPF_RET | BPF_K, 0),
    };
    const struct sock_fprog program = {.len = sizeof code / sizeof *code, .filter = code};
    int count = 0;
    for (int fd = 0; fd < SS_PACKETS_MAX_FD; ++fd) {
        if (mark->is_open[fd] || !is_bound_udp(fd)) {
            continue;
        }
        if (setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) != 0) {
            return -1;
        }
        ++count;
    }
    return count;
}
