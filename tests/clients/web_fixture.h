/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* softsim-web beside a real daemon, and a browser that is a socket of ours. cmocka comes first. */
#include <arpa/inet.h>
#include <dirent.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/folder_fixture.h"
#include "process/process.h"

enum { TEXT = 1, BINARY = 2, CLOSE = 8, PING = 9, PONG = 10, MESSAGE_SIZE = 1 << 20 };
enum { TOPOLOGY_FRAME = 1, DELTA_FRAME = 2, FIELD_FRAME = 3, FORCE_FRAME = 4, STATE_FORCE = 17 };

static process server, web;
static const char *address = "127.0.0.1"; /* of softsim-web */
static int port;

/* ---- sockets ---- */

/* `room`: bytes that wait for it to be read, 0 for what the system thinks best. */
static inline int dial_with_room(int room)
{
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    struct sockaddr_in place = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    inet_pton(AF_INET, address, &place.sin_addr);
    const struct timeval patience = {.tv_sec = (time_t)HANG_S};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (room > 0) {
        setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    }
    assert_int_equal(connect(fd, (const struct sockaddr *)&place, sizeof place), 0);
    return fd;
}

static inline int dial(void)
{
    return dial_with_room(0);
}

static inline bool say(int fd, const void *data, size_t size)
{
    return send(fd, data, size, MSG_NOSIGNAL) == (ssize_t)size;
}

static inline bool hear(int fd, void *out, size_t size)
{
    uint8_t *at = out;
    while (size > 0) {
        const ssize_t count = recv(fd, at, size, 0);
        if (count <= 0) {
            return false;
        }
        at += count;
        size -= (size_t)count;
    }
    return true;
}

/* The status of an answer, 0 without one; its head in `out_head`. */
static inline int hear_head(int fd, char *out_head, size_t size)
{
    size_t length = 0;
    int status = 0;
    while (length + 1 < size && hear(fd, out_head + length, 1)) {
        ++length;
        if (length >= 4 && memcmp(out_head + length - 4, "\r\n\r\n", 4) == 0) {
            break;
        }
    }
    out_head[length] = '\0';
    return sscanf(out_head, "HTTP/1.%*1[01] %d", &status) == 1 ? status : 0;
}

/* `request` is a whole one; the answer's status. */
static inline int ask(const char *request)
{
    char head[4096];
    const int fd = dial();
    say(fd, request, strlen(request));
    const int status = hear_head(fd, head, sizeof head);
    close(fd);
    return status;
}

static inline int get(const char *path, const char *more)
{
    char request[2048];
    snprintf(request, sizeof request, "GET %s HTTP/1.1\r\nHost: %s:%d\r\n%s\r\n", path, address,
             port, more);
    return ask(request);
}

/* ---- a browser ---- */

static inline int upgrade_on(int fd, const char *path, const char *more)
{
    char request[1024], head[4096];
    snprintf(request, sizeof request,
             "GET %s HTTP/1.1\r\nHost: %s:%d\r\nConnection: Upgrade\r\nUpgrade: "
             "websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
             "dGhlIHNhbXBsZSBub25jZQ==\r\n%s\r\n",
             path, address, port, more);
    say(fd, request, strlen(request));
    return hear_head(fd, head, sizeof head);
}

static inline int upgrade(const char *path, const char *more, int *out_status)
{
    const int fd = dial();
    *out_status = upgrade_on(fd, path, more);
    return fd;
}

static inline int open_browser_with_room(int room)
{
    const int fd = dial_with_room(room);
    assert_int_equal(upgrade_on(fd, "/ws", ""), 101);
    return fd;
}

static inline int open_browser(void)
{
    return open_browser_with_room(0);
}

/* A masked frame, as a browser sends it. */
static inline bool send_frame(int fd, int kind, const void *data, size_t size)
{
    uint8_t frame[8192] = {(uint8_t)(0x80 | kind)};
    size_t head = 2;
    assert_true(size < sizeof frame - 8);
    frame[1] = (uint8_t)(0x80 | (size < 126 ? size : 126));
    if (size >= 126) {
        frame[2] = (uint8_t)(size >> 8);
        frame[3] = (uint8_t)size;
        head = 4;
    }
    static const uint8_t mask[4] = {1, 2, 3, 4};
    memcpy(frame + head, mask, 4);
    for (size_t i = 0; i < size; ++i) {
        frame[head + 4 + i] = ((const uint8_t *)data)[i] ^ mask[i % 4];
    }
    return say(fd, frame, head + 4 + size);
}

static inline bool send_line(int fd, const char *line)
{
    return send_frame(fd, TEXT, line, strlen(line));
}

static uint8_t message[MESSAGE_SIZE + 1];

static inline int hear_any_frame(int fd, size_t *out_size)
{
    uint8_t head[10];
    *out_size = 0;
    bool is_last = false;
    int kind = 0;
    while (!is_last) {
        if (!hear(fd, head, 2)) {
            return 0;
        }
        is_last = (head[0] & 0x80) != 0;
        kind = kind != 0 ? kind : head[0] & 15;
        uint64_t size = head[1] & 127;
        const int more = size == 126 ? 2 : size == 127 ? 8 : 0;
        if (!hear(fd, head + 2, (size_t)more)) {
            return 0;
        }
        for (int i = 0; i < more; ++i) {
            size = (i > 0 ? size << 8 : 0) | head[2 + i];
        }
        assert_true(*out_size + size <= MESSAGE_SIZE);
        if (!hear(fd, message + *out_size, size)) {
            return 0;
        }
        *out_size += size;
    }
    message[*out_size] = '\0';
    return kind;
}

/* The next message's kind, its size in *out_size, itself in `message`; 0 when it is over. A ping is
 * answered, as browsers do: who is silent for 20 s is taken for gone. */
static inline int hear_frame(int fd, size_t *out_size)
{
    for (;;) {
        const int kind = hear_any_frame(fd, out_size);
        if (kind != PING) {
            return kind;
        }
        send_frame(fd, PONG, message, *out_size);
    }
}

/* Reads until a text with `part` comes. */
static inline void expect_text(int fd, const char *part)
{
    size_t size = 0;
    for (;;) {
        const int kind = hear_frame(fd, &size);
        if (kind == 0 || kind == CLOSE) {
            fail_msg("the connection has ended before %s", part);
        }
        if (kind == TEXT && strstr((const char *)message, part) != NULL) {
            return;
        }
    }
}

/* Reads until a frame of that first byte comes; its size. */
static inline size_t expect_frame(int fd, int first)
{
    size_t size = 0;
    for (;;) {
        const int kind = hear_frame(fd, &size);
        assert_int_not_equal(kind, 0);
        if (kind == BINARY && message[0] == first) {
            return size;
        }
    }
}

static inline void expect_end(int fd)
{
    size_t size = 0;
    int kind = 0;
    do {
        kind = hear_frame(fd, &size);
    } while (kind != 0 && kind != CLOSE);
    close(fd);
}

/* ---- start and end ---- */

static inline void start_web(const char *host, const char *token, const char *record_dir)
{
    const char *argv[12] = {"softsim-web", "--port", "0", "--host", host};
    int count = 5;
    if (token != NULL) {
        argv[count++] = "--token";
        argv[count++] = token;
    }
    if (record_dir != NULL) {
        argv[count++] = "--record-dir";
        argv[count++] = record_dir;
    }
    process_start(&web, argv, NULL);
    if (!process_wait_for(&web, " in a browser")) {
        fail_msg("%s", web.err);
    }
    const char *told = strstr(web.err, "open http://");
    assert_non_null(told);
    told = strchr(told + sizeof "open http://" - 1, ':');
    assert_non_null(told);
    port = atoi(told + 1);
}

static inline void stop_web(int status)
{
    process_signal(&web, SIGTERM);
    const int ended = process_finish(&web);
    if (ended != status) {
        fail_msg("softsim-web ended with %d:\n%s", ended, web.err);
    }
}

/* A server on this machine's own address and a browser on it. */
static inline int start_browsed(void)
{
    start_web("127.0.0.1", NULL, NULL);
    return open_browser();
}

static inline void stop_browsed(int fd)
{
    close(fd);
    stop_web(0);
}

static inline bool start_server(void)
{
    const char *const argv[] = {"softsimd", SOURCE_DIR "/server/scenes/kidney.yaml", "--realtime",
                                "off", NULL};
    process_start(&server, argv, NULL);
    return process_wait_for(&server, "softsimd: ready");
}

static inline int start_all(void **state)
{
    make_folder(state);
    return start_server() ? 0 : -1;
}

/* The number behind `key` in the last text. */
static inline double number_of(const char *key)
{
    const char *at = strstr((const char *)message, key);
    double number = 0.0;
    assert_non_null(at);
    assert_int_equal(sscanf(at + strlen(key), "%lf", &number), 1);
    return number;
}

/* Also of a test that failed. */
static inline int end_web(void **state)
{
    process_signal(&web, SIGKILL);
    process_finish(&web);
    return 0;
}

static inline int stop_all(void **state)
{
    process_signal(&server, SIGTERM);
    remove_folder(state);
    return process_finish(&server);
}

/* Of softsim-web. */
static inline int open_files(void)
{
    char path[64];
    int count = 0;
    snprintf(path, sizeof path, "/proc/%d/fd", (int)web.pid);
    DIR *folder_ = opendir(path);
    assert_non_null(folder_);
    while (readdir(folder_) != NULL) {
        ++count;
    }
    closedir(folder_);
    return count;
}

/* Goes without a goodbye: the server is told of a broken connection. */
static inline void cut(int fd)
{
    const struct linger none = {.l_onoff = 1};
    setsockopt(fd, SOL_SOCKET, SO_LINGER, &none, sizeof none);
    close(fd);
}

/* The time of the newest force in a frame of them. */
static inline float newest_time(void)
{
    uint16_t samples = 0;
    float time_s = 0.0F;
    memcpy(&samples, message + 2, sizeof samples);
    assert_true(samples > 0);
    memcpy(&time_s, message + 4 + 27 * 4 + 16 * (samples - 1), sizeof time_s);
    return time_s;
}

/* `frames` forces of a tool that goes in and out, so that the body moves all the time. */
static inline float press_in_and_out(int fd, int frames)
{
    for (int i = 0; i < frames; ++i) {
        assert_true(send_line(fd, i / 8 % 2 == 0 ? "aim 0 0 0.006 0.0238 1 0 0 0 0"
                                                 : "aim 0 0 0.006 0.0268 1 0 0 0 0"));
        expect_frame(fd, FORCE_FRAME);
    }
    return newest_time();
}
