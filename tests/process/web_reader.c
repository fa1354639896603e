/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Browsers that draw nothing: WebSockets to a softsim-web on this machine that read what comes, and
 * others that never read, for web_report.sh:
 *   web_reader PORT SECONDS READERS SLEEPERS
 * Says "counting" when every reader has the body and two seconds have passed, and SECONDS later, of
 * one reader in the mean: bytes a second, frames of the body a second, and the fewest of any.
 */
#include <arpa/inet.h>
#include <poll.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { MOST = 32, BINARY = 2, PING = 9, TOPOLOGY_FRAME = 1, DELTA_FRAME = 2, ROOM = 1 << 16 };

typedef struct reader {
    int fd;
    bool has_body;
    uint8_t head[15]; /* of the frame under way, and its first byte */
    int head_length;
    uint64_t left; /* of its payload */
    int64_t bytes, frames;
} reader;

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static void fail(const char *what)
{
    fprintf(stderr, "web_reader: %s\n", what);
    exit(EXIT_FAILURE);
}

static int dial(int port)
{
    char text[512];
    size_t length = 0;
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_port = htons((uint16_t)port),
                                        .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    if (connect(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        fail("nobody listens there");
    }
    const int size = snprintf(text, sizeof text,
                              "GET /ws HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nConnection: Upgrade\r\n"
                              "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
                              port);
    if (send(fd, text, (size_t)size, MSG_NOSIGNAL) != size) {
        fail("it does not listen");
    }
    do { /* the answer's head */
        if (length + 1 == sizeof text || recv(fd, text + length, 1, 0) != 1) {
            fail("no answer");
        }
        ++length;
    } while (length < 4 || memcmp(text + length - 4, "\r\n\r\n", 4) != 0);
    text[length] = '\0';
    if (strstr(text, " 101 ") == NULL) {
        fail("refused");
    }
    return fd;
}

/* A server's frame is not masked: 2 bytes, and 2 or 8 more where its length asks for them. */
static int head_size(const reader *r)
{
    const int size = r->head[1] & 127;
    return r->head_length < 2 ? 2 : size == 127 ? 10 : size == 126 ? 4 : 2;
}

static uint64_t payload_size(const reader *r)
{
    uint64_t size = r->head[1] & 127;
    const int head = head_size(r);
    for (int i = 2; i < head; ++i) {
        size = (i > 2 ? size << 8 : 0) | r->head[i];
    }
    return size;
}

static void begin_payload(reader *r)
{
    static const uint8_t pong[6] = {0x8A, 0x80, 0, 0, 0, 0};
    r->left = payload_size(r);
    if ((r->head[0] & 15) == PING && send(r->fd, pong, sizeof pong, MSG_NOSIGNAL) < 0) {
        fail("it hangs up");
    }
}

static void take(reader *r, const uint8_t *data, size_t size)
{
    r->bytes += (int64_t)size;
    for (size_t i = 0; i < size;) {
        if (r->left == 0) {
            r->head[r->head_length++] = data[i++];
            if (r->head_length >= 2 && r->head_length == head_size(r)) {
                begin_payload(r);
                r->head_length = r->left == 0 ? 0 : r->head_length;
            }
            continue;
        }
        if (r->head_length > 0) { /* the first byte of it */
            const bool is_body = (r->head[0] & 15) == BINARY;
            r->has_body = r->has_body || (is_body && data[i] == TOPOLOGY_FRAME);
            r->frames += is_body && data[i] == DELTA_FRAME;
            r->head_length = 0;
        }
        const uint64_t some = size - i < r->left ? size - i : r->left;
        r->left -= some;
        i += some;
    }
}

/* Until `end_ns`, or with 0 until all have the body. */
static void read_on(reader *reader_, int count, int64_t end_ns)
{
    static uint8_t data[ROOM];
    struct pollfd polled[MOST];
    for (bool is_over = false; !is_over;) {
        is_over = end_ns == 0 || now_ns() >= end_ns;
        for (int k = 0; k < count; ++k) {
            polled[k] = (struct pollfd){.fd = reader_[k].fd, .events = POLLIN};
            is_over = is_over && (end_ns != 0 || reader_[k].has_body);
        }
        if (poll(polled, (nfds_t)count, 50) < 0) {
            fail("poll failed");
        }
        for (int k = 0; k < count; ++k) {
            if (polled[k].revents != 0) {
                const ssize_t size = recv(reader_[k].fd, data, sizeof data, 0);
                if (size <= 0) {
                    fail("it hangs up");
                }
                take(&reader_[k], data, (size_t)size);
            }
        }
    }
}

int main(int argc, char **argv)
{
    static reader readers[MOST];
    if (argc != 5) {
        fail("give PORT SECONDS READERS SLEEPERS");
    }
    const int port = atoi(argv[1]), count = atoi(argv[3]), sleepers = atoi(argv[4]);
    const double seconds = atof(argv[2]);
    if (count < 0 || sleepers < 0 || count + sleepers > MOST) {
        fail("at most 32 in all");
    }
    for (int k = 0; k < count; ++k) {
        readers[k].fd = dial(port);
    }
    for (int k = 0; k < sleepers; ++k) {
        (void)dial(port);
    }
    read_on(readers, count, 0);
    read_on(readers, count, now_ns() + 2000000000LL);
    for (int k = 0; k < count; ++k) {
        readers[k].bytes = readers[k].frames = 0;
    }
    puts("counting");
    fflush(stdout);
    read_on(readers, count, now_ns() + (int64_t)(1e9 * seconds));
    double bytes = 0.0, frames = 0.0, fewest = count > 0 ? 1e30 : 0.0;
    for (int k = 0; k < count; ++k) {
        const double own = (double)readers[k].frames / seconds;
        bytes += (double)readers[k].bytes / seconds / count;
        frames += own / count;
        fewest = own < fewest ? own : fewest;
    }
    printf("%.0f %.1f %.1f\n", bytes, frames, fewest);
    return EXIT_SUCCESS;
}
