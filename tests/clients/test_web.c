/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-web as programs meet it: who gets in, what a browser is told and may say. The daemon and
 * the viewer are the real ones; the browser is a socket of ours.
 */
#include "common/test.h"

#include <dirent.h>
#include <inttypes.h>
#include <math.h>
#include <sys/stat.h>

#include "web_fixture.h"

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
    assert_int_equal(ask("GET / HTTP/1.1\r\nHost: localhost:8x\r\n\r\n"), 403);
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

/* A token shorter than its cookie's name, where the cookie is the last that is sent, or is not. */
TEST_WITH(a_short_token_is_known_by_its_cookie, NULL, end_web)
{
    static const char *const ends[] = {"", "; a=b"};
    char cookie[80];
    start_web("0.0.0.0", "8letters", NULL);
    for (int k = 0; k < 2; ++k) {
        snprintf(cookie, sizeof cookie, "Cookie: c=d; softsim_%d=8letters%s\r\n", port, ends[k]);
        assert_int_equal(get("/app.js", cookie), 200);
        snprintf(cookie, sizeof cookie, "Cookie: softsim_%d=8letter%s\r\n", port, ends[k]);
        assert_int_equal(get("/app.js", cookie), 403);
        snprintf(cookie, sizeof cookie, "Cookie: xsoftsim_%d=8letters%s\r\n", port, ends[k]);
        assert_int_equal(get("/app.js", cookie), 403);
    }
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

/* What it knows may be of a softsim-web before this one. A reply comes after all texts there are.
 */
TEST_WITH(a_browser_is_told_at_first_all_that_is, NULL, end_web)
{
    static const char *const told[2][3] = {
        {"\"silent\", \"is_silent\": false", "\"hand\", \"holder\": \"nobody\"",
         "\"is_temporary\": true"},
        {"\"silent\", \"is_silent\": false", "\"hand\", \"holder\": \"nobody\"",
         "\"is_temporary\": false"}};
    for (int k = 0; k < 2; ++k) {
        unsigned heard = 0;
        start_web("127.0.0.1", NULL, k == 0 ? NULL : folder);
        const int fd = open_browser();
        send_line(fd, "command status");
        do {
            expect_text(fd, "\"type\": ");
            for (unsigned i = 0; i < 3; ++i) {
                heard |= strstr((const char *)message, told[k][i]) != NULL ? 1U << i : 0;
            }
        } while (strstr((const char *)message, "\"type\": \"reply\"") == NULL);
        assert_int_equal(heard, 7);
        close(fd);
        stop_web(0);
    }
}

/* Who looks on ends no server that others use, and keeps nobody out with a tool that is none. */
TEST_WITH(a_browser_may_not_do_everything, NULL, end_web)
{
    start_web("127.0.0.1", NULL, NULL);
    const int fd = open_browser(), other = open_browser();
    expect_text(fd, "\"type\": \"scene\"");
    send_line(fd, "aim 2 0 0.006 0.06 1 0 0 0 0"); /* the kidney has tools 0 and 1 */
    send_line(fd, "command shutdown");
    expect_text(fd, "\"type\": \"reply\", \"code\": ");
    assert_non_null(strstr((const char *)message, "1, \"text\": \"stop the server where"));
    send_line(other, "aim 0 0 0.006 0.06 1 0 0 0 0");
    send_line(other, "command status");
    do {
        expect_text(other, "\"type\": ");
        assert_null(strstr((const char *)message, "\"holder\": \"another browser\""));
    } while (strstr((const char *)message, "\"holder\": \"you\"") == NULL);
    expect_text(other, "\"type\": \"reply\", \"code\": 0");
    close(fd);
    close(other);
    stop_web(0);
}

/* Waits for a text that says both. */
static void expect_both(int fd, const char *says, const char *too)
{
    do {
        expect_text(fd, says);
    } while (strstr((const char *)message, too) == NULL);
}

/* Whatever else the server has to say of itself. */
TEST_WITH(a_browser_knows_that_the_server_is_paused, NULL, end_web)
{
    const int fd = start_browsed();
    expect_text(fd, "\"type\": \"status\"");
    assert_non_null(strstr((const char *)message, "\"paused\": false"));
    send_line(fd, "command set publish.max_bytes_per_s=10000");
    send_line(fd, "command pause");
    expect_both(fd, "publish.max_bytes_per_s delays the mesh", "\"paused\": true");
    send_line(fd, "command resume");
    expect_text(fd, "\"paused\": false");
    send_line(fd, "command set publish.max_bytes_per_s=8000000");
    expect_text(fd, "\"type\": \"reply\", \"code\": 0, \"text\": \"publish.max_bytes_per_s = 8");
    stop_browsed(fd);
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

/* The same body, and not one of the old dents; a recording of both says so. */
TEST_WITH(a_server_that_starts_again_is_shown_afresh, NULL, end_web)
{
    const int fd = start_browsed();
    expect_frame(fd, TOPOLOGY_FRAME);
    expect_text(fd, "\"type\": \"status\"");
    const double session = number_of("\"session\": ");
    send_line(fd, "record 1");
    expect_text(fd, "\"is_recording\": true");
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
    send_line(fd, "record 0");
    expect_text(fd, "\"is_recording\": false, \"fault\": \"more than one server answered in it\"");
    send_line(fd, "record 1");
    expect_text(fd, "\"is_recording\": true");
    send_line(fd, "record 0");
    expect_text(fd, "\"is_recording\": false, \"fault\": \"\"");
    stop_browsed(fd);
}

/* A server that takes steps of two millimetres only, and a mouse that jumps by thirty. */
TEST_WITH(no_pose_jumps_further_than_the_server_takes, NULL, end_web)
{
    enum { JUMPS = 10 };
    const int fd = start_browsed();
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
    stop_browsed(fd);
}

/* The potential of the cells under a press, with its unit; a body of no law has no energy. */
TEST_WITH(a_browser_is_told_the_field_that_it_asks_for, NULL, end_web)
{
    const int fd = start_browsed();
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
    stop_browsed(fd);
}

/* The path of what is in `parent`, where nothing else is. */
static void take_only_name(const char *parent, char out_path[512])
{
    DIR *entries = opendir(parent);
    int count = 0;
    assert_non_null(entries);
    for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries)) {
        if (entry->d_name[0] != '.') {
            snprintf(out_path, 512, "%.200s/%.200s", parent, entry->d_name);
            ++count;
        }
    }
    closedir(entries);
    assert_int_equal(count, 1);
}

/* Whoever had the probe in the test before holds it for half a second: what is refused meanwhile is
 * in the recording, and is not played. */
TEST_WITH(a_recording_can_be_fetched_and_read, NULL, end_web)
{
    char path[512], request[256];
    start_web("127.0.0.1", NULL, folder);
    const int fd = open_browser();
    send_line(fd, "record 1");
    expect_text(fd, "\"type\": \"recording\", \"is_recording\": true");
    press_in_and_out(fd, 60);
    send_line(fd, "record 0");
    expect_text(fd, "\"is_recording\": false, \"fault\": \"\", \"files\": [\"softsim-");
    const char *name = strstr((const char *)message, "softsim-");
    snprintf(request, sizeof request, "/recordings/%.*s", (int)strcspn(name, "\""), name);
    assert_int_equal(get(request, ""), 200);
    snprintf(path, sizeof path, "%s/%s", folder, request + sizeof "/recordings/" - 1);
    static process run;
    const char *const argv[] = {
        "softsim-run", SOURCE_DIR "/server/scenes/kidney.yaml", "--poses", path, "--hash", NULL};
    if (process_run(&run, argv) != 0) {
        fail_msg("%s", run.err);
    }
    stop_browsed(fd);
}

/* A folder that has come to stand in its place. */
TEST_WITH(a_recording_that_cannot_be_finished_at_the_end_is_told, NULL, end_web)
{
    char path[512], part[512];
    assert_int_equal(mkdir(in_folder("taken"), 0700), 0);
    start_web("127.0.0.1", NULL, in_folder("taken"));
    const int fd = open_browser();
    send_line(fd, "record 1");
    expect_text(fd, "\"type\": \"recording\", \"is_recording\": true");
    take_only_name(in_folder("taken"), part);
    snprintf(path, sizeof path, "%.*s", (int)(strlen(part) - strlen(".part")), part);
    assert_int_equal(mkdir(path, 0700), 0);
    close(fd);
    stop_web(1);
    assert_non_null(strstr(web.err, ".lcmlog: cannot write: "));
    assert_non_null(strstr(web.err, part));
    assert_int_equal(access(part, R_OK), 0);
}

/* Makes a recording, and that larger than what waits in the kernel; the request for it. */
static void make_large_recording(int fd, int64_t size, char out_request[256])
{
    char path[512];
    send_line(fd, "record 1");
    expect_text(fd, "\"type\": \"recording\", \"is_recording\": true");
    send_line(fd, "record 0");
    expect_text(fd, "\"is_recording\": false, \"fault\": \"\", \"files\": [\"softsim-");
    const char *name = strstr((const char *)message, "softsim-");
    const int length = (int)strcspn(name, "\"");
    snprintf(path, sizeof path, "%s/%.*s", folder, length, name);
    assert_int_equal(truncate(path, size), 0);
    snprintf(out_request, 256,
             "GET /recordings/%.*s HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n",
             length, name);
}

/* Connections that come and say nothing put out each other, not who takes a file at his own pace.
 */
TEST_WITH(who_takes_a_recording_gets_the_whole, NULL, end_web)
{
    enum { MORE = 24 << 20, SILENT = 120, CHUNK = 1 << 16 };
    static char chunk[CHUNK];
    char request[256];
    int silent[SILENT];
    int64_t size = 0;
    start_web("127.0.0.1", NULL, folder);
    const int fd = open_browser();
    make_large_recording(fd, MORE, request);
    const int taker = dial();
    assert_true(say(taker, request, strlen(request)));
    for (int k = 0; size < MORE; ++k) {
        const ssize_t got = recv(taker, chunk, sizeof chunk, 0);
        assert_true(got > 0);
        size += got;
        if (k < SILENT) {
            silent[k] = dial();
        }
    }
    for (int k = 0; k < SILENT; ++k) {
        close(silent[k]);
    }
    close(taker);
    stop_browsed(fd);
}

/* As `nc -N` does: the request is all that it has to say. */
TEST_WITH(who_half_closes_after_a_request_gets_the_whole_file, NULL, end_web)
{
    enum { MORE = 24 << 20, CHUNK = 1 << 16 };
    static const char page[] =
        "GET /app.js HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n";
    static char chunk[CHUNK];
    char requests[2][256];
    start_web("127.0.0.1", NULL, folder);
    const int fd = open_browser();
    make_large_recording(fd, MORE, requests[0]);
    memcpy(requests[1], page, sizeof page);
    for (int k = 0; k < 2; ++k) {
        int64_t size = 0, length = 0;
        const int taker = dial();
        assert_true(say(taker, requests[k], strlen(requests[k])));
        shutdown(taker, SHUT_WR);
        assert_int_equal(hear_head(taker, chunk, sizeof chunk), 200);
        const char *told = strcasestr(chunk, "content-length: ");
        assert_non_null(told);
        assert_int_equal(sscanf(told + sizeof "content-length:", "%" SCNd64, &length), 1);
        for (ssize_t got = 1; got > 0; size += got > 0 ? got : 0) {
            got = recv(taker, chunk, sizeof chunk, 0);
        }
        assert_int_equal(size, length);
        close(taker);
    }
    stop_browsed(fd);
}

/* However it goes, in the middle of a recording or after one that is empty, no file stays open. */
TEST_WITH(a_recording_is_closed_when_its_taker_goes, NULL, end_web)
{
    enum { MORE = 24 << 20, TAKERS = 20 };
    char request[256], head[4096];
    int taker[TAKERS];
    start_web("127.0.0.1", NULL, folder);
    const int fd = open_browser();
    const int files = open_files(); /* no other connection is just being closed */
    for (int64_t size = 0; size <= MORE; size += MORE) {
        make_large_recording(fd, size, request);
        for (int k = 0; k < TAKERS; ++k) {
            taker[k] = dial();
            assert_true(say(taker[k], request, strlen(request)));
            assert_int_equal(hear_head(taker[k], head, sizeof head), 200);
            assert_true(k > 0 || size == 0 || open_files() >= files + 2); /* the second: the file */
        }
        for (int k = 0; k < TAKERS; ++k) {
            if (k % 2 == 0) {
                cut(taker[k]);
            } else {
                close(taker[k]);
            }
        }
        while (open_files() > files) {
            assert_int_equal(get("/", ""), 200);
        }
    }
    stop_browsed(fd);
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
