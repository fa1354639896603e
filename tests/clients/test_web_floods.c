/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-web under hostile input: what is sent away, what crowds, floods and slow readers do to
 * the others, and to it.
 */
#include "common/test.h"

#include <math.h>
#include <poll.h>

#include "rt/random.h"
#include "web_fixture.h"

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

/* What is no request is closed at once, and keeps no place while the library parts with it; those
 * who say nothing after it have no more of them than before. */
TEST_WITH(what_is_no_request_keeps_nobody_out, NULL, end_web)
{
    enum { SILENT = 200, PLACES = 64 };
    static const char foo[] = "FOO / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
                      tls[] = "\x16\x03\x01\x02";
    int silent[SILENT];
    start_web("127.0.0.1", NULL, NULL);
    assert_int_equal(get("/", ""), 200);
    const int files = open_files();
    for (int k = 0; k < 2; ++k) {
        const int fd = dial();
        const char *said = k == 0 ? foo : tls;
        assert_true(send(fd, said, strlen(said), MSG_NOSIGNAL) > 0);
        assert_int_equal(get("/", ""), 200); /* it has been read since */
        close(fd);
    }
    for (int k = 0; k < SILENT; ++k) {
        silent[k] = dial();
    }
    assert_int_equal(get("/", ""), 200);
    assert_true(open_files() <= files + PLACES);
    for (int k = 0; k < SILENT; ++k) {
        close(silent[k]);
    }
    stop_web(0);
}

static int64_t cpu_ticks(void)
{
    char path[64], text[1024];
    (void)snprintf(path, sizeof path, "/proc/%d/stat", (int)web.pid);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    assert_non_null(fgets(text, sizeof text, file));
    fclose(file);
    long long user = 0, system = 0;
    assert_int_equal(sscanf(strrchr(text, ')'),
                            ") %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %lld %lld", &user,
                            &system),
                     2);
    return user + system;
}

/* Until the other side has closed; how many answers came. */
static int hear_out(int fd)
{
    static char text[1 << 16];
    size_t size = 0;
    int answers = 0;
    for (ssize_t got = 1; got > 0 && size<sizeof text - 1; size += got> 0 ? (size_t)got : 0) {
        got = recv(fd, text + size, sizeof text - 1 - size, 0);
    }
    text[size] = '\0';
    for (const char *at = text; (at = strstr(at, "HTTP/1.")) != NULL; ++at) {
        ++answers;
    }
    return answers;
}

/* The library would go round without sleeping while what has come on a connection stays unread, for
 * the five seconds in which it parts with it, and while requests wait behind what nobody takes. */
TEST_WITH(what_stays_unread_costs_nothing, NULL, end_web)
{
    enum { MORE = 9000, TIMES = 30 };
    static const char none[] = "GET /none HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
                      page[] = "GET /app.js HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
    char much[MORE], many[TIMES * sizeof none] = "", files[TIMES * sizeof page] = "";
    memset(much, 'A', sizeof much);
    for (int k = 0; k < TIMES; ++k) {
        strcat(many, none);
        strcat(files, page);
    }
    start_web("127.0.0.1", NULL, NULL);
    assert_int_equal(get("/", ""), 200);
    const int64_t before = cpu_ticks();
    const char *const said[] = {much, "FOO\r\n\r\n", many};
    const size_t sizes[] = {sizeof much, 7, strlen(many)};
    const int taken = dial(); /* and nothing of it is read */
    assert_true(send(taken, files, strlen(files), MSG_NOSIGNAL) > 0);
    for (int k = 0; k < 3; ++k) {
        const int fd = dial();
        assert_true(send(fd, said[k], sizes[k], MSG_NOSIGNAL) > 0);
        if (k == 1) {
            shutdown(fd, SHUT_WR);
        }
        const int answers = hear_out(fd);
        assert_true(k == 2 ? answers == 1 : answers <= 1);
        close(fd);
    }
    struct pollfd end = {.fd = taken, .events = POLLRDHUP};
    (void)poll(&end, 1,
               5000); /* until it is parted with as well, or for as long as it would cost */
    assert_int_equal(get("/", ""), 200);
    assert_true(cpu_ticks() - before < sysconf(_SC_CLK_TCK));
    close(taken);
    stop_web(0);
}

/* Reads to the end of a connection: does it say that another has its place? */
static bool is_displaced(int fd)
{
    size_t size = 0;
    int kind = 0;
    do {
        kind = hear_frame(fd, &size);
    } while (kind != 0 && kind != CLOSE);
    return kind == CLOSE && size >= 2 && (message[0] << 8 | message[1]) == 4000;
}

/* Of those who only watch, or only answer pings, the one that has said nothing for longest gives
 * way to the next; it is told so. Whoever says something stays. */
TEST_WITH(a_full_room_has_a_place_for_the_next, NULL, end_web)
{
    enum { ROOM = 32, MORE = 20 };
    int crowd[ROOM], next[MORE];
    start_web("127.0.0.1", NULL, NULL);
    const int user = open_browser();
    for (int i = 1; i < ROOM; ++i) {
        crowd[i] = open_browser();
        send_frame(crowd[i], PONG, "", 0);
    }
    send_line(user, "command status");
    expect_text(user, "\"type\": \"reply\", \"code\": 0");
    for (int i = 0; i < MORE; ++i) {
        next[i] = open_browser();
        expect_text(next[i], "\"type\": \"status\"");
    }
    for (int i = 1; i < ROOM; ++i) {
        if (i <= MORE) {
            assert_true(is_displaced(crowd[i]));
        } else {
            expect_text(crowd[i], "\"type\": \"status\"");
        }
        close(crowd[i]);
    }
    send_line(user, "command status");
    expect_text(user, "\"type\": \"reply\", \"code\": 0");
    for (int i = 0; i < MORE; ++i) {
        close(next[i]);
    }
    close(user);
    stop_web(0);
}

/* More at once than there is room for, none of whom says a word: who uses the page stays. */
TEST_WITH(a_burst_displaces_nobody_who_is_there, NULL, end_web)
{
    enum { BURST = 40 };
    int crowd[BURST];
    start_web("127.0.0.1", NULL, NULL);
    const int user = open_browser();
    send_line(user, "command status");
    expect_text(user, "\"type\": \"reply\", \"code\": 0");
    for (int i = 0; i < BURST; ++i) {
        crowd[i] = open_browser();
        expect_text(crowd[i], "\"type\": \"status\"");
    }
    send_line(user, "command status");
    expect_text(user, "\"type\": \"reply\", \"code\": 0");
    for (int i = 0; i < BURST; ++i) {
        close(crowd[i]);
    }
    close(user);
    stop_web(0);
}

/* A hundred who want a WebSocket: of those who may, the last as many as there is room for. */
TEST_WITH(a_crowd_gets_what_room_there_is, NULL, end_web)
{
    enum { CROWD = 100, ROOM = 32 };
    int crowd[CROWD], status = 0;
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
        assert_int_equal(status, 101);
    }
    for (int i = 0; i < CROWD; ++i) {
        if (i < CROWD - ROOM) {
            expect_end(crowd[i]);
        } else {
            expect_text(crowd[i], "\"type\": \"status\"");
            cut(crowd[i]);
        }
    }
    close(upgrade("/ws?token=a-secret-of-ours", "", &status));
    assert_int_equal(status, 101);
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

int main(void)
{
    return process_run_tests(start_all, stop_all);
}
