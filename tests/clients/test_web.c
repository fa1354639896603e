/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-web as programs meet it: who gets in, what a browser is told and may say, what the
 * hostile get. The daemon and the viewer are the real ones; the browser is a socket of ours.
 */
#include "common/test.h"

#include <arpa/inet.h>
#include <dirent.h>
#include <inttypes.h>
#include <math.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/folder_fixture.h"
#include "process/process.h"
#include "rt/random.h"

enum { TEXT = 1, BINARY = 2, CLOSE = 8, PING = 9, PONG = 10, MESSAGE_SIZE = 1 << 20 };
enum { TOPOLOGY_FRAME = 1, DELTA_FRAME = 2, FIELD_FRAME = 3, FORCE_FRAME = 4, STATE_FORCE = 17 };

static process server, web;
static const char *address = "127.0.0.1"; /* of softsim-web */
static int port;

/* ---- sockets ---- */

/* `room`: bytes that wait for it to be read, 0 for what the system thinks best. */
static int dial_with_room(int room)
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

static int dial(void)
{
    return dial_with_room(0);
}

static bool say(int fd, const void *data, size_t size)
{
    return send(fd, data, size, MSG_NOSIGNAL) == (ssize_t)size;
}

static bool hear(int fd, void *out, size_t size)
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
static int hear_head(int fd, char *out_head, size_t size)
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
static int ask(const char *request)
{
    char head[4096];
    const int fd = dial();
    say(fd, request, strlen(request));
    const int status = hear_head(fd, head, sizeof head);
    close(fd);
    return status;
}

static int get(const char *path, const char *more)
{
    char request[2048];
    snprintf(request, sizeof request, "GET %s HTTP/1.1\r\nHost: %s:%d\r\n%s\r\n", path, address,
             port, more);
    return ask(request);
}

/* ---- a browser ---- */

static int upgrade_on(int fd, const char *path, const char *more)
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

static int upgrade(const char *path, const char *more, int *out_status)
{
    const int fd = dial();
    *out_status = upgrade_on(fd, path, more);
    return fd;
}

static int open_browser_with_room(int room)
{
    const int fd = dial_with_room(room);
    assert_int_equal(upgrade_on(fd, "/ws", ""), 101);
    return fd;
}

static int open_browser(void)
{
    return open_browser_with_room(0);
}

/* A masked frame, as a browser sends it. */
static bool send_frame(int fd, int kind, const void *data, size_t size)
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

static bool send_line(int fd, const char *line)
{
    return send_frame(fd, TEXT, line, strlen(line));
}

static uint8_t message[MESSAGE_SIZE + 1];

static int hear_any_frame(int fd, size_t *out_size)
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
static int hear_frame(int fd, size_t *out_size)
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
static void expect_text(int fd, const char *part)
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
static size_t expect_frame(int fd, int first)
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

static void expect_end(int fd)
{
    size_t size = 0;
    int kind = 0;
    do {
        kind = hear_frame(fd, &size);
    } while (kind != 0 && kind != CLOSE);
    close(fd);
}

/* ---- start and end ---- */

static void start_web(const char *host, const char *token, const char *record_dir)
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

static void stop_web(int status)
{
    process_signal(&web, SIGTERM);
    const int ended = process_finish(&web);
    if (ended != status) {
        fail_msg("softsim-web ended with %d:\n%s", ended, web.err);
    }
}

static bool start_server(void)
{
    const char *const argv[] = {"softsimd", SOURCE_DIR "/server/scenes/kidney.yaml", "--realtime",
                                "off", NULL};
    process_start(&server, argv, NULL);
    return process_wait_for(&server, "softsimd: ready");
}

static int start_all(void **state)
{
    make_folder(state);
    return start_server() ? 0 : -1;
}

/* The number behind `key` in the last text. */
static double number_of(const char *key)
{
    const char *at = strstr((const char *)message, key);
    double number = 0.0;
    assert_non_null(at);
    assert_int_equal(sscanf(at + strlen(key), "%lf", &number), 1);
    return number;
}

/* Also of a test that failed. */
static int end_web(void **state)
{
    process_signal(&web, SIGKILL);
    process_finish(&web);
    return 0;
}

static int stop_all(void **state)
{
    process_signal(&server, SIGTERM);
    remove_folder(state);
    return process_finish(&server);
}

/* ---- claims ---- */

TEST_WITH(only_pages_of_ours_get_in, NULL, end_web)
{
    int status = 0;
    char origin[128];
    start_web("127.0.0.1", NULL, NULL);
    assert_int_equal(get("/", ""), 200);
    assert_int_equal(get("/app.js", ""), 200);
    assert_int_equal(get("/app.css", ""), 200);
    assert_int_equal(get("/nothing", ""), 404);
    assert_int_equal(get("/../../etc/passwd", ""), 404);
    assert_int_equal(get("/recordings/x.lcmlog", ""), 404);
    assert_int_equal(get("/recordings/%2e%2e%2f%2e%2e%2fetc%2fpasswd", ""), 404);
    assert_int_equal(ask("GET / HTTP/1.1\r\nHost: attacker.example\r\n\r\n"), 403);
    close(upgrade("/ws", "Origin: http://attacker.example\r\n", &status));
    assert_int_equal(status, 403);
    close(upgrade("/ws", "Origin: null\r\n", &status));
    assert_int_equal(status, 403);
    close(upgrade("/elsewhere", "", &status));
    assert_int_equal(status, 404);
    snprintf(origin, sizeof origin, "Origin: https://127.0.0.1:%d\r\n", port);
    close(upgrade("/ws", origin, &status)); /* the page is http, and only that */
    assert_int_equal(status, 403);
    snprintf(origin, sizeof origin, "Origin: http://127.0.0.1:%d\r\n", port);
    close(upgrade("/ws", origin, &status));
    assert_int_equal(status, 101);
    stop_web(0);
}

static int end_elsewhere(void **state)
{
    address = "127.0.0.1";
    return end_web(state);
}

TEST_WITH(another_address_of_loopback_is_its_own_name, NULL, end_elsewhere)
{
    int status = 0;
    char line[128];
    address = "127.0.0.2";
    start_web(address, NULL, NULL);
    assert_int_equal(get("/", ""), 200);
    snprintf(line, sizeof line, "Origin: http://127.0.0.2:%d\r\n", port);
    close(upgrade("/ws", line, &status));
    assert_int_equal(status, 101);
    snprintf(line, sizeof line, "GET / HTTP/1.1\r\nHost: localhost:%d\r\n\r\n", port);
    assert_int_equal(ask(line), 200);
    assert_int_equal(ask("GET / HTTP/1.1\r\nHost: 127.0.0.3\r\n\r\n"), 403);
    assert_int_equal(ask("GET / HTTP/1.1\r\nHost: 127.0.0.22\r\n\r\n"), 403);
    assert_int_equal(ask("GET / HTTP/1.1\r\nHost: attacker.example\r\n\r\n"), 403);
    stop_web(0);
}

TEST_WITH(beyond_loopback_only_with_the_token, NULL, end_web)
{
    static const char *const bare[] = {"softsim-web", "--host", "0.0.0.0", NULL};
    int status = 0;
    assert_int_equal(process_run(&web, bare), 2);
    assert_non_null(strstr(web.err, "give --token"));
    start_web("0.0.0.0", "a-secret-of-ours", NULL);
    assert_int_equal(get("/", ""), 403);
    assert_int_equal(get("/?token=a-secret-of-other", ""), 403);
    assert_int_equal(get("/?token=a-secret-of-ours", ""), 200);
    /* What the page is made of comes with the page's cookie, and not without. */
    char cookie[80];
    snprintf(cookie, sizeof cookie, "Cookie: a=b; softsim_%d=a-secret-of-ours\r\n", port);
    assert_int_equal(get("/app.js", ""), 403);
    assert_int_equal(get("/app.js", cookie), 200);
    assert_int_equal(get("/app.css", cookie), 200);
    close(upgrade("/ws", "", &status));
    assert_int_equal(status, 403);
    close(upgrade("/ws?token=a-secret-of-ours", "", &status));
    assert_int_equal(status, 101);
    stop_web(0);
}

TEST_WITH(a_browser_sees_the_body_and_pushes_it, NULL, end_web)
{
    start_web("127.0.0.1", NULL, NULL);
    const int first = open_browser(); /* of whom it is not said what comes first */
    expect_text(first, "\"type\": \"scene\"");
    close(first);
    const int fd = open_browser();
    expect_text(fd, "\"type\": \"scene\", \"name\": \"kidney.yaml\", \"model\": \"cnn-energy\"");
    assert_non_null(strstr((const char *)message, "\"form\": \"sphere\", \"size\": [0.005"));
    assert_non_null(
        strstr((const char *)message, "{\"path\": \"haptic.max_force_n\", \"value\": "));
    const size_t size = expect_frame(fd, TOPOLOGY_FRAME);
    uint32_t nodes = 0;
    memcpy(&nodes, message + 4, sizeof nodes);
    assert_true(nodes > 1000 && size > 16 + 13 * (size_t)nodes);
    expect_text(fd, "\"type\": \"status\", \"status\": {");

    /* Half a millimetre into the kidney where README's bridge presses it. */
    float force = 0.0F;
    bool is_moved = false;
    while (!is_moved || !(force > 0.05F)) {
        assert_true(send_line(fd, "aim 0 0 0.006 0.0258 1 0 0 0 0"));
        size_t length = 0;
        const int kind = hear_frame(fd, &length);
        assert_int_not_equal(kind, 0);
        is_moved = is_moved || (kind == BINARY && message[0] == DELTA_FRAME);
        if (kind == BINARY && message[0] == FORCE_FRAME) {
            float value[27];
            memcpy(value, message + 4, sizeof value);
            force = fmaxf(force, sqrtf(value[STATE_FORCE] * value[STATE_FORCE] +
                                       value[STATE_FORCE + 1] * value[STATE_FORCE + 1] +
                                       value[STATE_FORCE + 2] * value[STATE_FORCE + 2]));
            assert_true(isfinite(force));
        }
    }
    const int other = open_browser();
    expect_text(other, "\"type\": \"hand\", \"holder\": \"another browser\"");
    /* It goes without a word, and the other may have it. */
    close(fd);
    expect_text(other, "\"type\": \"hand\", \"holder\": \"nobody\"");
    send_line(other, "aim 0 0 0.006 0.06 1 0 0 0 0");
    expect_text(other, "\"type\": \"hand\", \"holder\": \"you\"");
    send_line(other, "drop");
    expect_text(other, "\"type\": \"hand\", \"holder\": \"nobody\"");
    send_line(other, "command set haptic.max_force_n=3");
    expect_text(other, "\"type\": \"reply\", \"code\": 0, \"text\": \"haptic.max_force_n = 3 N");
    send_line(other, "command nonsense");
    expect_text(other, "\"type\": \"reply\", \"code\": 2");
    send_line(other, "command reset");
    expect_text(other, "\"type\": \"reply\", \"code\": 0");
    close(other);
    stop_web(0);
}

/* The time of the newest force in a frame of them. */
static float newest_time(void)
{
    uint16_t samples = 0;
    float time_s = 0.0F;
    memcpy(&samples, message + 2, sizeof samples);
    assert_true(samples > 0);
    memcpy(&time_s, message + 4 + 27 * 4 + 16 * (samples - 1), sizeof time_s);
    return time_s;
}

/* `frames` forces of a tool that goes in and out, so that the body moves all the time. */
static float press_in_and_out(int fd, int frames)
{
    for (int i = 0; i < frames; ++i) {
        assert_true(send_line(fd, i / 8 % 2 == 0 ? "aim 0 0 0.006 0.0238 1 0 0 0 0"
                                                 : "aim 0 0 0.006 0.0268 1 0 0 0 0"));
        expect_frame(fd, FORCE_FRAME);
    }
    return newest_time();
}

/* Whatever else the server has to say of itself. */
TEST_WITH(a_browser_knows_that_the_server_is_paused, NULL, end_web)
{
    start_web("127.0.0.1", NULL, NULL);
    const int fd = open_browser();
    expect_text(fd, "\"type\": \"status\"");
    assert_non_null(strstr((const char *)message, "\"paused\": false"));
    send_line(fd, "command set publish.max_bytes_per_s=10000");
    send_line(fd, "command pause");
    do {
        expect_text(fd, "publish.max_bytes_per_s delays the mesh");
    } while (strstr((const char *)message, "\"paused\": true") == NULL);
    send_line(fd, "command resume");
    expect_text(fd, "\"paused\": false");
    send_line(fd, "command set publish.max_bytes_per_s=8000000");
    expect_text(fd, "\"type\": \"reply\", \"code\": 0, \"text\": \"publish.max_bytes_per_s = 8");
    close(fd);
    stop_web(0);
}

/* The surface before the forces, which are of ten seconds, so that none of them is of nothing. */
TEST_WITH(a_late_browser_gets_the_forces_of_before, NULL, end_web)
{
    enum { FRAMES = 100 };
    start_web("127.0.0.1", NULL, NULL);
    const int early = open_browser();
    expect_frame(early, TOPOLOGY_FRAME);
    press_in_and_out(early, FRAMES);
    const int late = open_browser();
    size_t size = 0;
    while (hear_frame(late, &size) != BINARY) {
    }
    assert_int_equal(message[0], TOPOLOGY_FRAME);
    expect_frame(late, FORCE_FRAME);
    uint16_t samples = 0;
    memcpy(&samples, message + 2, sizeof samples);
    assert_true(samples >= FRAMES);
    close(early);
    close(late);
    stop_web(0);
}

/* The same body, and not one of the old dents. */
TEST_WITH(a_server_that_starts_again_is_shown_afresh, NULL, end_web)
{
    start_web("127.0.0.1", NULL, NULL);
    const int fd = open_browser();
    expect_frame(fd, TOPOLOGY_FRAME);
    expect_text(fd, "\"type\": \"status\"");
    const double session = number_of("\"session\": ");
    press_in_and_out(fd, 60);
    send_line(fd, "drop");
    process_signal(&server, SIGTERM);
    assert_int_equal(process_finish(&server), 0);
    expect_text(fd, "\"type\": \"silent\", \"is_silent\": true");
    assert_true(start_server());
    expect_text(fd, "\"type\": \"status\"");
    assert_true(number_of("\"session\": ") != session);
    expect_text(fd, "\"is_silent\": false");
    expect_frame(fd, TOPOLOGY_FRAME);
    close(fd);
    stop_web(0);
}

/* A server that takes steps of two millimetres only, and a mouse that jumps by thirty. */
TEST_WITH(no_pose_jumps_further_than_the_server_takes, NULL, end_web)
{
    enum { JUMPS = 10 };
    start_web("127.0.0.1", NULL, NULL);
    const int fd = open_browser();
    send_line(fd, "command set haptic.max_jump_m=0.002");
    expect_text(fd, "{\"path\": \"haptic.max_jump_m\", \"value\": \"0.002\"");
    for (int i = 0; i < JUMPS; ++i) {
        const float y = i % 2 == 0 ? 0.06F : 0.09F;
        float place[4] = {0};
        char line[64];
        snprintf(line, sizeof line, "aim 0 0 0.006 %.3f 1 0 0 0 0", (double)y);
        do {
            assert_true(send_line(fd, line));
            expect_frame(fd, FORCE_FRAME);
            memcpy(place, message + 4, sizeof place);
        } while (fabsf(place[3] - y) > 1e-3F);
    }
    expect_text(fd, "\"type\": \"status\"");
    expect_text(fd, "\"type\": \"status\"");
    int64_t jumps = -1;
    const char *refused = strstr((const char *)message, "\"poses_refused\": [");
    assert_non_null(refused);
    assert_int_equal(sscanf(refused, "\"poses_refused\": [%*d, %*d, %*d, %*d, %" SCNd64, &jumps),
                     1);
    assert_int_equal(jumps, 0);
    send_line(fd, "command set haptic.max_jump_m=0.05");
    expect_text(fd, "\"type\": \"reply\", \"code\": 0, \"text\": \"haptic.max_jump_m = 0.05");
    close(fd);
    stop_web(0);
}

/* The potential of the cells under a press, with its unit; a body of no law has no energy. */
TEST_WITH(a_browser_is_told_the_field_that_it_asks_for, NULL, end_web)
{
    start_web("127.0.0.1", NULL, NULL);
    const int fd = open_browser();
    expect_text(fd, "none|displacement|potential\"");
    send_line(fd, "command set publish.field=energy");
    expect_text(fd,
                "\"type\": \"reply\", \"code\": 1, \"text\": \"publish.field: this body has no");
    send_line(fd, "command set publish.field=potential");
    float high = 0.0F;
    while (!(high > 1e-7F)) {
        assert_true(send_line(fd, "aim 0 0 0.006 0.0258 1 0 0 0 0"));
        expect_frame(fd, FIELD_FRAME);
        memcpy(&high, message + 12, sizeof high);
        assert_string_equal((const char *)message + 16, "potential");
        assert_string_equal((const char *)message + 48, "J");
    }
    send_line(fd, "command set publish.field=none");
    expect_text(fd, "\"type\": \"reply\", \"code\": 0");
    close(fd);
    stop_web(0);
}

TEST_WITH(a_recording_can_be_fetched_and_read, NULL, end_web)
{
    char path[512], request[256];
    start_web("127.0.0.1", NULL, folder);
    const int fd = open_browser();
    send_line(fd, "record 1");
    expect_text(fd, "\"type\": \"recording\", \"is_recording\": true");
    for (int i = 0; i < 3; ++i) {
        send_line(fd, "aim 0 0 0.006 0.06 1 0 0 0 0");
        expect_frame(fd, FORCE_FRAME);
    }
    send_line(fd, "record 0");
    expect_text(fd, "\"is_recording\": false, \"fault\": \"\", \"files\": [\"softsim-");
    const char *name = strstr((const char *)message, "softsim-");
    snprintf(request, sizeof request, "/recordings/%.*s", (int)strcspn(name, "\""), name);
    assert_int_equal(get(request, ""), 200);
    snprintf(path, sizeof path, "%s/%s", folder, request + sizeof "/recordings/" - 1);
    static process run;
    const char *const argv[] = {
        "softsim-run", SOURCE_DIR "/server/scenes/kidney.yaml", "--poses", path, "--hash", NULL};
    assert_int_equal(process_run(&run, argv), 0);
    close(fd);
    stop_web(0);
}

TEST_WITH(the_hostile_are_sent_away_and_the_rest_served, NULL, end_web)
{
    enum { CROWD = 200, ROUNDS = 40 };
    char line[1024];
    start_web("127.0.0.1", NULL, NULL);
    const int good = open_browser();
    expect_text(good, "\"type\": \"status\"");

    static const char *const bad[] = {"",
                                      "nonsense",
                                      "aim",
                                      "aim 0 nan 0 0 1 0 0 0",
                                      "aim 9 0 0 0 1 0 0 0 0",
                                      "aim 0 0 0 0 1 0 0 0 0 0",
                                      "aim 0 0x 0 0 1 0 0 0 0",
                                      "record 2",
                                      "drop it"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        const int fd = open_browser();
        send_line(fd, bad[i]);
        expect_end(fd);
    }
    int fd = open_browser(); /* a line that is too long */
    memset(line, 'a', sizeof line);
    send_frame(fd, TEXT, line, sizeof line);
    expect_end(fd);
    fd = open_browser(); /* no text */
    send_frame(fd, BINARY, "drop", 4);
    expect_end(fd);
    fd = open_browser(); /* a NUL in it */
    send_frame(fd, TEXT, "dr\0p", 4);
    expect_end(fd);
    fd = open_browser(); /* not masked, of 2^62 bytes */
    static const uint8_t endless[] = {0x81, 127, 0x40, 0, 0, 0, 0, 0, 0, 0, 'x'};
    say(fd, endless, sizeof endless);
    close(fd);
    fd = open_browser(); /* as many lines as the wire takes */
    for (int i = 0; i < 4000 && send_line(fd, "drop"); ++i) {
    }
    expect_end(fd);

    /* Crowds of which nobody says more than half a word, or anything at all: there is room for the
     * next who says it all, again and again, while they stand there. */
    static int crowd[2][CROWD];
    for (int round = 0; round < ROUNDS; ++round) {
        int *crowd_now = crowd[round % 2];
        for (int i = 0; i < CROWD; ++i) {
            if (round >= 2) {
                close(crowd_now[i]);
            }
            crowd_now[i] = dial();
            say(crowd_now[i], "GET / HT", i % 2 == 0 ? 8 : 0);
        }
        assert_int_equal(get("/", ""), 200);
    }
    send_line(good, "command status");
    expect_text(good, "\"type\": \"reply\", \"code\": 0");
    for (int i = 0; i < CROWD; ++i) {
        close(crowd[0][i]);
        close(crowd[1][i]);
    }
    assert_int_equal(get("/", ""), 200);
    static char long_request[70000];
    memset(long_request, 'a', sizeof long_request - 1);
    memcpy(long_request, "GET /", 5);
    fd = dial();
    say(fd, long_request, sizeof long_request);
    close(fd);
    assert_int_equal(get("/", ""), 200);
    close(good);
    stop_web(0);
}

/* ---- floods ---- */

static uint64_t random_state;

static int draw(int below)
{
    return (int)ss_random_below(&random_state, (uint32_t)below);
}

static int open_files(void)
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
static void cut(int fd)
{
    const struct linger none = {.l_onoff = 1};
    setsockopt(fd, SOL_SOCKET, SO_LINGER, &none, sizeof none);
    close(fd);
}

/* A request of a hostile kind, then some of its bytes turned, doubled or cut off. */
static size_t make_request(char *out, size_t room)
{
    static const char *const kinds[] = {
        "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nRange: bytes=-1\r\n\r\nGET /app.js HTTP/1.1\r\n\r\n",
        "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n\r\nx",
        "POST /ws HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nffffffffff\r\n",
        "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        "GET http://127.0.0.1/%00%2e%2e/%ff?token=%zz&&&=&token HTTP/1.0\r\n\r\n",
        "HEAD /recordings/../../../../etc/shadow HTTP/1.1\r\nHost: 127.0.0.1:1\r\n\r\n",
        "GET /ws HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 99\r\nSec-WebSocket-Key: x\r\nSec-WebSocket-Extensions: "
        "permessage-deflate; server_max_window_bits=99\r\n\r\n",
        "OPTIONS * HTTP/1.1\r\nHost: localhost\r\nOrigin: http://a.example\r\nCookie: a\r\n\r\n"};
    const char *kind = kinds[draw((int)(sizeof kinds / sizeof kinds[0]))];
    size_t size = strlen(kind);
    memcpy(out, kind, size);
    for (int turns = draw(6); turns > 0; --turns) {
        const size_t at = (size_t)draw((int)size), some = (size_t)draw((int)(size - at)) + 1;
        if (draw(3) == 0 && size + 40 * some < room) { /* a part forty times */
            memmove(out + at + 40 * some, out + at, size - at);
            for (size_t k = 0; k < 40; ++k) {
                memmove(out + at + k * some, out + at + 40 * some, some);
            }
            size += 40 * some;
        } else {
            out[at] = (char)draw(256);
        }
    }
    return draw(4) == 0 ? (size_t)draw((int)size) : size;
}

/* A frame of any kind, length and mask, whose payload may be less than it says. */
static size_t make_frame(uint8_t *out)
{
    static const uint64_t sizes[] = {0, 1, 5, 125, 126, 513, 65536, UINT64_C(1) << 40, UINT64_MAX};
    const uint64_t size = sizes[draw((int)(sizeof sizes / sizeof sizes[0]))];
    const uint8_t mask = draw(8) == 0 ? 0 : 0x80;
    size_t length = 2;
    out[0] = (uint8_t)(draw(2) == 0 ? 0x80 | draw(3) : draw(256));
    out[1] = (uint8_t)(mask | (size < 126 ? size : size < 65536 ? 126 : 127));
    for (int shift = size < 126 ? -8 : size < 65536 ? 8 : 56; shift >= 0; shift -= 8) {
        out[length++] = (uint8_t)(size >> shift);
    }
    for (uint64_t k = 0; k < (mask ? 4U : 0U) + (size < 600 ? size : 600) && draw(50) > 0; ++k) {
        out[length++] = (uint8_t)draw(256);
    }
    return length;
}

/* Random requests and frames, one connection after the other and some byte by byte: each is sent
 * away or leaves by itself, no file stays open, and whoever comes then is served. */
TEST_WITH(floods_of_random_input_leave_nothing_behind, NULL, end_web)
{
    enum { ROUNDS = 250, SLOW = 8 };
    static uint8_t bytes[1 << 16];
    start_web("127.0.0.1", NULL, NULL);
    assert_int_equal(get("/", ""), 200);
    const int files = open_files();
    int slow[SLOW];
    random_state = 20260101;
    for (int k = 0; k < SLOW; ++k) {
        slow[k] = dial();
    }
    for (int n = 0; n < ROUNDS; ++n) {
        const bool is_web_socket = draw(2) == 0;
        const int fd = is_web_socket ? open_browser() : dial();
        for (int pieces = is_web_socket ? 1 + draw(6) : 1; pieces > 0; --pieces) {
            const size_t size =
                is_web_socket ? make_frame(bytes) : make_request((char *)bytes, sizeof bytes);
            say(fd, bytes, size);
        }
        say(slow[n % SLOW], &"GET / HTTP/1.1\r\nX: aaaaaaaaaaaaaaaaaaaaaaaaaa"[n / SLOW], 1);
        if (draw(2) == 0) {
            recv(fd, bytes, sizeof bytes, MSG_DONTWAIT);
        }
        if (draw(2) == 0) {
            cut(fd);
        } else {
            close(fd);
        }
    }
    for (int k = 0; k < SLOW; ++k) { /* a head that never ends is waited for ten seconds */
        while (recv(slow[k], bytes, sizeof bytes, 0) > 0) {
        }
        close(slow[k]);
    }
    const int good = open_browser();
    send_line(good, "command status");
    expect_text(good, "\"type\": \"reply\", \"code\": 0");
    close(good);
    while (open_files() > files) {
        assert_int_equal(get("/", ""), 200);
    }
    stop_web(0);
}

/* A hundred who want a WebSocket: of those who may, as many as there is room for; then the next. */
TEST_WITH(a_crowd_gets_what_room_there_is, NULL, end_web)
{
    enum { CROWD = 100 };
    int crowd[CROWD], status = 0, served = 0;
    start_web("127.0.0.1", "a-secret-of-ours", NULL);
    for (int i = 0; i < CROWD; ++i) {
        static const char *const wrong[][2] = {
            {"/ws", ""},
            {"/ws?token=a-secret-of-other", ""},
            {"/ws?token=a-secret-of-ours", "Origin: http://attacker.example\r\n"}};
        close(upgrade(wrong[i % 3][0], wrong[i % 3][1], &status));
        assert_int_equal(status, 403);
    }
    for (int i = 0; i < CROWD; ++i) {
        crowd[i] = upgrade("/ws?token=a-secret-of-ours", "", &status);
        assert_true(status == 101 || status == 503);
        served += status == 101;
    }
    assert_int_equal(served, 32);
    for (int i = 0; i < CROWD; ++i) {
        cut(crowd[i]);
    }
    do { /* until it has seen that they are gone */
        close(upgrade("/ws?token=a-secret-of-ours", "", &status));
    } while (status == 503);
    assert_int_equal(status, 101);
    stop_web(0);
}

/* However its browser goes, the probe is let go and another browser may have it. */
TEST_WITH(a_probe_is_let_go_however_its_browser_goes, NULL, end_web)
{
    enum { GOODBYE, BROKEN, HALF_A_FRAME, SENT_AWAY, WAYS };
    start_web("127.0.0.1", NULL, NULL);
    for (int way = 0; way < WAYS; ++way) {
        const int holder = open_browser(), watcher = open_browser();
        send_line(holder, "aim 0 0 0.006 0.06 1 0 0 0 0");
        expect_text(holder, "\"type\": \"hand\", \"holder\": \"you\"");
        expect_text(watcher, "\"type\": \"hand\", \"holder\": \"another browser\"");
        if (way == GOODBYE) {
            send_frame(holder, CLOSE, "\x03\xe8", 2);
            close(holder);
        } else if (way == SENT_AWAY) {
            send_line(holder, "nonsense");
            expect_end(holder);
        } else {
            say(holder, "\x81\xfe\x01", way == HALF_A_FRAME ? 3 : 0);
            cut(holder);
        }
        expect_text(watcher, "\"type\": \"hand\", \"holder\": \"nobody\"");
        close(watcher);
    }
    stop_web(0);
}

/* What softsim-web's side of a connection has not got rid of, in bytes. */
static unsigned count_unsent(int fd)
{
    char line[512];
    struct sockaddr_in own;
    socklen_t size = sizeof own;
    unsigned local = 0, remote = 0, waiting = 0;
    assert_int_equal(getsockname(fd, (struct sockaddr *)&own, &size), 0);
    FILE *file = fopen("/proc/net/tcp", "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file) != NULL) {
        if (sscanf(line, " %*d: %*x:%x %*x:%x %*x %x", &local, &remote, &waiting) == 3 &&
            local == (unsigned)port && remote == ntohs(own.sin_port)) {
            fclose(file);
            return waiting;
        }
    }
    fclose(file);
    fail_msg("no connection from port %d", ntohs(own.sin_port));
    return 0;
}

/* One that never reads is left behind with what the surface takes, and nobody else with it. */
TEST_WITH(who_does_not_read_holds_up_nobody, NULL, end_web)
{
    enum { ROOM = 4096, FRAMES = 200, MOST = 1 << 17 };
    start_web("127.0.0.1", NULL, NULL);
    const int asleep = open_browser_with_room(ROOM), awake = open_browser();
    expect_frame(awake, TOPOLOGY_FRAME);
    press_in_and_out(awake, FRAMES);
    const unsigned stalled = count_unsent(asleep);
    assert_true(stalled > ROOM); /* it does stall */
    press_in_and_out(awake, FRAMES);
    assert_int_equal(count_unsent(asleep), stalled); /* and nothing more waits for it */
    assert_true(stalled < MOST);
    send_line(awake, "command status");
    expect_text(awake, "\"type\": \"reply\", \"code\": 0");
    close(asleep);
    close(awake);
    stop_web(0);
}

/* One that has not read for a while gets what is new then, after what little was on its way. */
TEST_WITH(a_slow_browser_skips_to_the_newest, NULL, end_web)
{
    enum { ROOM = 4096, FRAMES = 300 };
    start_web("127.0.0.1", NULL, NULL);
    const int slow = open_browser_with_room(ROOM), quick = open_browser();
    expect_frame(quick, TOPOLOGY_FRAME);
    press_in_and_out(quick, 1);
    expect_frame(slow, TOPOLOGY_FRAME);
    expect_frame(slow, FORCE_FRAME);
    const float now_s = press_in_and_out(quick, FRAMES);
    int stale = 0;
    do {
        expect_frame(slow, FORCE_FRAME);
        ++stale;
    } while (newest_time() < now_s);
    if (stale > FRAMES / 2) {
        fail_msg("%d frames before it was told of now", stale);
    }
    close(slow);
    close(quick);
    stop_web(0);
}

TEST_WITH(bad_arguments_are_named, NULL, end_web)
{
    static const char *const bad[][3] = {{"--host", "nowhere", "give an IPv4 address"},
                                         {"--token", "short", "give 8 to 100 characters"},
                                         {"--record-dir", "/nonexistent", "not a folder"},
                                         {"--port", "70000", "65535"},
                                         {"--lcm-url", "tcpq://", "only udpm"}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        const char *const argv[] = {"softsim-web", bad[i][0], bad[i][1], NULL};
        assert_int_equal(process_run(&web, argv), 2);
        assert_non_null(strstr(web.err, bad[i][2]));
    }
    char taken[16];
    start_web("127.0.0.1", NULL, NULL);
    snprintf(taken, sizeof taken, "%d", port);
    static process second;
    const char *const argv[] = {"softsim-web", "--port", taken, NULL};
    assert_int_equal(process_run(&second, argv), 1);
    assert_non_null(strstr(second.err, "is the port taken"));
    stop_web(0);
}

int main(void)
{
    return process_run_tests(start_all, stop_all);
}
