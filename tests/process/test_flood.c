/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Under a flood of hostile packets every program starts, the probe's holder keeps it and is
 * answered, and nothing is lost count of. How late forces get depends on the machine and is not
 * judged here: flood_report.sh measures it.
 */
#include "common/test.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/pose_fixture.h"
#include "daemon_fixture.h"
#include "softsim/client.h"
#include "softsim_contact_force_t.h"

static process flooder;

static int end_all(void **state)
{
    process_signal(&flooder, SIGKILL);
    process_finish(&flooder);
    return tear_down(state);
}

static void start_flood_from(const char *sockets, const char *kind, const char *rate,
                             const char *seconds)
{
    const char *const argv[] = {"flood", kind,        "--rate", rate, "--sockets",
                                sockets, "--seconds", seconds,  NULL};
    process_start(&flooder, argv, NULL);
}

static void start_flood(const char *kind, const char *rate, const char *seconds)
{
    start_flood_from("1", kind, rate, seconds);
}

static void expect_run(const char *const *argv)
{
    if (process_run(&client, argv) != 0) {
        fail_msg("%s: status %d: %s", argv[0], client.status, client.err);
    }
}

/* LCM reads between its bind and any filter that is attached later: 18 of 30 servers died here. */
TEST_WITH(every_program_starts_under_fragments, make_folder, end_all)
{
    enum { STARTS = 4 };
    const char *const server[] = {"softsimd", tube(), "--duration", "0.05", NULL};
    const char *const monitor[] = {"softsim-monitor", "--once", "--json", NULL};
    const char *const bridge[] = {"softsim-bridge", "--device", "sim", "--offset-m",
                                  "0,0,0",          "--ticks",  "700", NULL};
    FILE *file = open_file("still.csv");
    fputs("time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,0,0,3,1,0,0,0,0\n0.7,0,0,0,3,1,0,0,0,0\n",
          file);
    fclose(file);
    const char *const replay[] = {"softsim-replay", in_folder("still.csv"), NULL};
    start_flood("fragment-wrap", "20000", "600");
    for (int i = 0; i < STARTS; ++i) {
        expect_run(server);
    }
    start_daemon(tube(), NULL);
    for (int i = 0; i < STARTS; ++i) {
        expect_run(monitor);
    }
    /* Each new sender waits half a second for the one before to let go. */
    expect_run(bridge);
    expect_run(replay);
    assert_int_equal(stop_daemon(), 0);
}

/* What others send to test the group neither is taken for the own test nor hides it, also where
 * other hosts are heard. */
TEST_WITH(a_server_starts_under_the_self_tests_of_others, make_folder, end_all)
{
    static const char *const urls[] = {"udpm://239.255.76.67:7667?ttl=0",
                                       "udpm://239.255.76.67:7667?ttl=1"};
    start_flood("self-test", "0", "600");
    for (int u = 0; u < 2; ++u) {
        const char *const server[] = {"softsimd",  tube(),  "--duration", "0.05",
                                      "--lcm-url", urls[u], NULL};
        expect_run(server);
    }
    process_signal(&flooder, SIGKILL); /* it was there until now */
    assert_int_equal(process_finish(&flooder), 128 + SIGKILL);
}

/* ---- a server under flood ---- */

/* By a client of ours: LCM's own receiver would not live through this. */
typedef struct listener {
    softsim_client *client;
    softsim_server_status status;
    int64_t densest_us;             /* the least between one status and the next */
    int32_t replied_id, reply_code; /* of the newest reply */
} listener;

static void take_status(void *context, const softsim_server_status *status, int64_t now)
{
    listener *l = context;
    (void)now;
    if (l->status.seq > 0) {
        const int64_t apart_us = (status->utime - l->status.utime) / (status->seq - l->status.seq);
        l->densest_us = apart_us < l->densest_us ? apart_us : l->densest_us;
    }
    l->status = *status;
}

static void take_reply(void *context, int32_t id, int32_t code, const char *text)
{
    listener *l = context;
    (void)text;
    l->replied_id = id;
    l->reply_code = code;
}

static void listen_open(listener *l)
{
    softsim_error error = {.status = SOFTSIM_OK};
    *l = (listener){.densest_us = INT64_MAX};
    const softsim_client_config config = {
        .context = l, .handle_status = take_status, .handle_reply = take_reply};
    assert_int_equal(softsim_client_open(&config, &l->client, &error), SOFTSIM_OK);
}

static void listen_to_daemon(listener *l)
{
    start_daemon(tube(), NULL);
    listen_open(l);
}

static void listen_close(listener *l)
{
    softsim_client_close(&l->client);
    assert_int_equal(stop_daemon(), 0);
}

/* A status that was made after the call: one machine, one monotonic clock. Fails after a minute. */
static const softsim_server_status *listen_next(listener *l)
{
    const int64_t called_us = softsim_client_now_us();
    const int64_t deadline_ns = softsim_client_now_ns() + 60000000000;
    while (l->status.utime <= called_us) {
        assert_true(softsim_client_wait(l->client, deadline_ns) >= 0);
        assert_true(softsim_client_now_ns() < deadline_ns);
    }
    return &l->status;
}

static int64_t accepted(const softsim_server_status *status)
{
    int64_t count = status->poses_received;
    for (int i = 0; i < SOFTSIM_REFUSED_COUNT; ++i) {
        count -= status->poses_refused[i];
    }
    return count;
}

/* Until the server has taken `count` more poses. */
static void listen_accepted(listener *l, int64_t count)
{
    const int64_t wanted = accepted(listen_next(l)) + count;
    for (int tries = 0; accepted(listen_next(l)) < wanted; ++tries) {
        assert_true(tries < 100);
    }
}

static void start_bridge(listener *l)
{
    const char *const bridge[] = {"softsim-bridge", "--device", "sim", "--offset-m", "0,0,0", NULL};
    process_start(&client, bridge, NULL);
    listen_accepted(l, 200);
}

/* `may_be_paused`: by a command, which it says, and for which it fails. */
static void stop_bridge(bool may_be_paused)
{
    process_signal(&client, SIGINT);
    const int status = process_finish(&client);
    const bool was_paused = may_be_paused && strstr(client.err, "the server is paused ");
    if (status != was_paused) {
        fail_msg("softsim-bridge: %d: %s%s", client.status, client.out, client.err);
    }
    assert_null(strstr(client.err, "another sender holds"));
    assert_null(strstr(client.err, "two servers"));
    assert_null(strstr(client.err, "at fault"));
}

static void flood_beside_bridge(listener *l, const char *kind, const char *rate,
                                const char *seconds)
{
    listen_to_daemon(l);
    start_bridge(l);
    start_flood(kind, rate, seconds);
    assert_int_equal(process_finish(&flooder), 0);
}

TEST_WITH(the_holder_is_answered_under_all_kinds_at_once, make_folder, end_all)
{
    listener l;
    flood_beside_bridge(&l, "mixed", "10000", "2");
    listen_accepted(&l, 200);
    const int64_t *refused = l.status.poses_refused;
    assert_true(refused[SOFTSIM_REFUSED_MALFORMED] > 0);
    assert_true(refused[SOFTSIM_REFUSED_TYPE_HASH] > 0);
    assert_true(refused[SOFTSIM_REFUSED_NOT_FINITE] > 0);
    assert_true(refused[SOFTSIM_REFUSED_OTHER_SENDER] > 0);
    assert_true(refused[SOFTSIM_REFUSED_WRONG_PROBE] > 0);
    assert_true(l.status.probe_forces[0] > 0);
    assert_int_equal(l.status.probe_forces[0] + l.status.probe_missed[0],
                     l.status.probe_periods[0]);
    stop_bridge(true); /* pause is one of the kinds */
    listen_close(&l);
}

/* Every force tells the holder's number to all; poses far ahead of it under that number from
 * another address once took the probe: the holder's own were no longer the newer ones. */
TEST_WITH(poses_under_the_holders_number_change_nothing, make_folder, end_all)
{
    listener l;
    flood_beside_bridge(&l, "pose-holder", "1000", "1");
    assert_true(listen_next(&l)->poses_refused[SOFTSIM_REFUSED_OTHER_SENDER] > 0);
    assert_int_equal(l.status.poses_refused[SOFTSIM_REFUSED_OTHER], 0);
    listen_accepted(&l, 200);
    stop_bridge(false);
    listen_close(&l);
}

/* What is beyond the budget is not answered, and what comes after is. */
TEST_WITH(commands_have_a_budget, make_folder, end_all)
{
    const char *const monitor[] = {"softsim-monitor", "--command", "status", NULL};
    listener l;
    listen_to_daemon(&l);
    start_flood("command-status", "2000", "1");
    assert_int_equal(process_finish(&flooder), 0);
    assert_true(listen_next(&l)->poses_refused[SOFTSIM_REFUSED_OTHER] > 0);
    listen_next(&l);
    listen_next(&l); /* half a second later the budget has something again */
    expect_run(monitor);
    listen_close(&l);
}

/* Each says less than one may, and all together more than all may: a request or command of somebody
 * new once found that nothing was left. */
TEST_WITH(slow_floods_of_many_keep_no_newcomer_out, make_folder, end_all)
{
    static const char *const floods[][2] = {{"command-status", "24"},
                                            {"command-status", "32"},
                                            {"command-status", "128"},
                                            {"command-pause", "32"}};
    enum { NEWCOMERS = 6 };
    const char *const monitor[] = {"softsim-monitor", "--command", "status", NULL};
    const char *const resume[] = {"softsim-monitor", "--command", "resume", NULL};
    for (size_t f = 0; f < sizeof floods / sizeof *floods; ++f) {
        listener l;
        listen_to_daemon(&l);
        start_flood_from(floods[f][1], floods[f][0], "1200", "600");
        /* All who flood are known by then. */
        const int64_t *refused = &l.status.poses_refused[SOFTSIM_REFUSED_OTHER];
        for (int tries = 0; listen_next(&l) && *refused < 600; ++tries) {
            assert_true(tries < 200);
        }
        for (int i = 0; i < NEWCOMERS; ++i) {
            expect_run(strcmp(floods[f][0], "command-pause") == 0 ? resume : monitor);
        }
        process_signal(&flooder, SIGKILL); /* it was there until now */
        assert_int_equal(process_finish(&flooder), 128 + SIGKILL);
        listen_close(&l);
    }
}

/* Each request was answered by a status of its own, to all: a server that was asked often enough
 * spoke as often as one who floods, and its clients and other servers took it for one. */
TEST_WITH(requests_of_many_are_answered_by_few_statuses, make_folder, end_all)
{
    listener l;
    listen_to_daemon(&l);
    listen_next(&l);
    start_flood_from("8", "command-status", "4000", "1");
    assert_int_equal(process_finish(&flooder), 0);
    assert_true(listen_next(&l)->poses_refused[SOFTSIM_REFUSED_OTHER] > 0);
    assert_true(l.densest_us < 250000); /* asked, it answers sooner than it would speak */
    assert_true(l.densest_us >= 50000); /* and twenty times a second at most */
    listen_close(&l);
}

/* The holder's commands, one after the other, under a flood of `kind`. */
static void expect_no_command_lost_under(const char *scene, const char *sockets, const char *kind,
                                         const char *rate)
{
    enum { COMMANDS = 40 };
    listener l;
    start_daemon(scene, NULL);
    listen_open(&l);
    const softsim_pose pose = {.utime_us = softsim_client_now_us(),
                               .sender = softsim_client_sender(l.client),
                               .seq = 1,
                               .position = {0.0, 0.0, 0.3},
                               PLAIN_POSE};
    assert_true(softsim_client_send_pose(l.client, &pose, 0));
    start_flood_from(sockets, kind, rate, "600");
    /* Requests beyond the budget are counted; statuses come from a second server. */
    for (int tries = 0; listen_next(&l)->poses_refused[SOFTSIM_REFUSED_OTHER] == 0 &&
                        softsim_client_read_counts(l.client).second == 0;
         ++tries) {
        assert_true(tries < 100);
    }
    for (int i = 0; i < COMMANDS; ++i) {
        const int32_t id = softsim_client_send_command(l.client, i % 2 ? "resume" : "pause", "");
        const int64_t deadline_ns = softsim_client_now_ns() + 60000000000;
        assert_true(id > 0);
        while (l.replied_id != id) {
            assert_true(softsim_client_wait(l.client, deadline_ns) >= 0);
            if (softsim_client_now_ns() >= deadline_ns) {
                fail_msg("command %d of %d was lost under a flood of %s", i + 1, COMMANDS, kind);
            }
        }
        assert_int_equal(l.reply_code, 0);
    }
    process_signal(&flooder, SIGKILL); /* it was there until now */
    assert_int_equal(process_finish(&flooder), 128 + SIGKILL);
    listen_close(&l);
}

static void expect_no_command_lost(const char *kind)
{
    expect_no_command_lost_under(tube(), "1", kind, "20000");
}

TEST_WITH(a_flood_of_status_requests_loses_no_command, make_folder, end_all)
{
    expect_no_command_lost("command-status");
}

TEST_WITH(a_flood_of_statuses_loses_no_command, make_folder, end_all)
{
    expect_no_command_lost("status");
}

/* The flooder takes its share, and no more. */
TEST_WITH(a_flood_of_commands_loses_no_command_of_another, make_folder, end_all)
{
    expect_no_command_lost("command-pause");
}

/* Each is slow enough never to be muted, and asks for more than its budget: all places are busy. */
TEST_WITH(slow_floods_of_many_lose_no_command_of_another, make_folder, end_all)
{
    expect_no_command_lost_under(tube(), "8", "command-pause", "1200");
}

/* The loops take commands once a step: while one that is slow, or has no processor, takes its time,
 * those of others once left no room for the holder's, which was refused as one too many. */
TEST_WITH(slow_floods_of_many_lose_no_command_of_another_between_slow_steps, make_folder, end_all)
{
    char text[2048];
    tube();
    read_text("tube.yaml", text, sizeof text);
    const size_t size = strlen(text);
    snprintf(text + size, sizeof text - size, "simulation: {rate_hz: 5}\n");
    expect_no_command_lost_under(write_text("slow.yaml", text), "8", "command-pause", "1200");
}

/* Statuses that another process forges as fast as it can filled the monitor's buffer: the server
 * was not heard, was taken for silent, and the forger was shown in its place. */
TEST_WITH(a_monitor_stays_with_the_server_it_heard_first, make_folder, end_all)
{
    const char *const monitor[] = {"softsim-monitor", "--json", NULL};
    static const char seq[] = "\"seq\": ";
    start_daemon(tube(), NULL);
    process_start(&client, monitor, NULL);
    assert_true(process_wait_for(&client, "\"scene\""));
    start_flood("status", "0", "600");
    assert_true(process_wait_for(&client, "two servers answer"));
    /* Its statuses come four a second: one that was made later. */
    const char *last = client.out;
    for (const char *at = last; (at = strstr(at, seq)) != NULL; at += strlen(seq)) {
        last = at;
    }
    char later[32];
    snprintf(later, sizeof later, "%s%ld,", seq, strtol(last + strlen(seq), NULL, 10) + 8);
    assert_true(process_wait_for(&client, later));
    assert_null(strstr(client.out, "\"flood\""));
    process_signal(&flooder, SIGKILL); /* it was there until now */
    assert_int_equal(process_finish(&flooder), 128 + SIGKILL);
    process_signal(&client, SIGINT);
    assert_int_equal(process_finish(&client), 1); /* two were heard */
    assert_int_equal(stop_daemon(), 0);
}

/* ---- forces ---- */

static int forces;

static void count_force(void *context, const softsim_force *force, int64_t now_ns)
{
    (void)context;
    (void)force;
    (void)now_ns;
    ++forces;
}

static void send_datagram(int fd, const void *data, int32_t size)
{
    const struct sockaddr_in group = {.sin_family = AF_INET,
                                      .sin_port = htons(7667),
                                      .sin_addr.s_addr = inet_addr("239.255.76.67")};
    assert_int_equal(
        sendto(fd, data, (size_t)size, 0, (const struct sockaddr *)&group, sizeof group), size);
}

/* Another force of the server, and everything before it. */
static void expect_force(softsim_client *heard, int fd, const void *data, int32_t size)
{
    const int before = forces;
    send_datagram(fd, data, size);
    while (forces == before) {
        assert_true(softsim_client_wait(heard, softsim_client_now_ns() + 60000000000) > 0);
    }
}

/* Large datagrams, of which few fill the socket's buffer, or many small ones held up each force of
 * the server by 30 to 50 ms: they are not let in. */
TEST_WITH(what_others_send_among_the_forces_is_not_let_in, NULL, NULL)
{
    enum { HEAD = sizeof "LC02....T_FORCE_0", LARGE = 60000, ROUNDS = 600, AT_ONCE = 100 };
    static uint8_t good[1024], bad[LARGE];
    const softsim_client_config config = {
        .prefix = "T", .handle_force = count_force, .hears_all = true};
    const softsim_contact_force_t force = {.sender = 1};
    softsim_error error = {.status = SOFTSIM_OK};
    softsim_client *heard = NULL;
    assert_int_equal(softsim_client_open(&config, &heard, &error), SOFTSIM_OK);
    memcpy(good, "LC02\0\0\0\0T_FORCE_0", HEAD);
    memcpy(bad, good, HEAD);
    const int32_t size =
        HEAD + softsim_contact_force_t_encode(good + HEAD, 0, sizeof good - HEAD, &force);
    const int server = socket(AF_INET, SOCK_DGRAM, 0), flood = socket(AF_INET, SOCK_DGRAM, 0);
    const int ttl = 0;
    setsockopt(server, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
    setsockopt(flood, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
    forces = 0;
    expect_force(heard, server, good, size);
    for (int i = 0; i < AT_ONCE; ++i) {
        send_datagram(flood, bad, i % 2 == 0 ? LARGE : size + 1);
    }
    expect_force(heard, server, good, size);
    assert_int_equal(softsim_client_read_counts(heard).malformed, 0);
    const int64_t start_ns = softsim_client_now_ns();
    for (int k = 0; k < ROUNDS; ++k) {
        for (int i = 0; i < AT_ONCE; ++i) {
            send_datagram(flood, bad, size);
        }
        expect_force(heard, server, good, size);
    }
    /* No flood where the machine is too slow for one: an honest sender says 8000 a second. */
    const double taken_s = 1e-9 * (double)(softsim_client_now_ns() - start_ns);
    const int64_t others = softsim_client_read_counts(heard).malformed;
    assert_true(others > 0);
    assert_true(others < ROUNDS * AT_ONCE / 3 || ROUNDS * AT_ONCE < 30000.0 * taken_s);
    softsim_client_close(&heard);
    close(server);
    close(flood);
}

int main(void)
{
    return process_run_tests(NULL, NULL);
}
