/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* softsim-web without a network: what a browser is sent of a body, and how its mouse moves a probe.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "body.h"
#include "mouse.h"
#include "rt/random.h"
#include "rt/vec.h"

/* ---- the body ---- */

enum { NODES = 6, TRIANGLES = 4, ROOM = 16 };

static ss_body_view body;

/* Nodes first .. first + nodes - 1 and triangles alike, of number `topology`. */
static bool take_chunk(int32_t topology, int32_t first, int32_t nodes, int32_t first_triangle,
                       int32_t triangles)
{
    static int32_t file_node[NODES], triangle[3 * TRIANGLES];
    static uint8_t flag[NODES];
    static float rest[3 * NODES];
    for (int32_t i = 0; i < 3 * nodes; ++i) {
        rest[i] = (float)(3 * first + i);
    }
    for (int32_t i = 0; i < 3 * triangles; ++i) {
        triangle[i] = (first_triangle + i) % NODES;
    }
    for (int32_t i = 0; i < nodes; ++i) {
        flag[i] = (uint8_t)((first + i) % 2);
    }
    const softsim_topology_chunk chunk = {.topology = topology,
                                          .node_count = NODES,
                                          .triangle_count = TRIANGLES,
                                          .first_node = first,
                                          .node_chunk = nodes,
                                          .first_triangle = first_triangle,
                                          .triangle_chunk = triangles,
                                          .scale = 0.5F,
                                          .file_node = file_node,
                                          .node_flag = flag,
                                          .rest = rest,
                                          .triangle = triangle};
    return ss_body_take_topology(&body, &chunk);
}

static void take_delta(int32_t topology, int32_t node, int16_t x)
{
    const int16_t displacement[3] = {x, 0, 0};
    const softsim_mesh_delta delta = {
        .topology = topology, .count = 1, .node = &node, .displacement = displacement};
    ss_body_take_delta(&body, &delta);
}

/* The kind of the next frame for a browser, 0 without one; what it is of in `frame`. */
static uint8_t frame[512];
static size_t size;
static int next_frame(ss_body_copy *copy)
{
    uint8_t *sent = ss_body_frame(&body, copy, ROOM, &size);
    if (sent == NULL) {
        return 0;
    }
    memcpy(frame, sent + ROOM, size);
    free(sent);
    return frame[0];
}

static int forget_body(void **state)
{
    ss_body_free(&body);
    body = (ss_body_view){0};
    return 0;
}

TEST_WITH(a_body_is_shown_when_all_of_it_is_there, NULL, forget_body)
{
    ss_body_copy copy = {0};
    uint32_t number = 0;
    assert_true(take_chunk(1, 3, 3, 2, 2));
    assert_true(take_chunk(1, 3, 3, 2, 2)); /* twice counts once */
    assert_int_equal(next_frame(&copy), 0);
    assert_true(take_chunk(1, 0, 3, 0, 2));
    assert_int_equal(next_frame(&copy), 1);
    assert_int_equal(size, 16 + NODES * 13 + TRIANGLES * 12);
    memcpy(&number, frame + 4, 4);
    assert_int_equal(number, NODES);
    float last = 0.0F;
    memcpy(&last, frame + 16 + (3 * NODES - 1) * 4, 4);
    assert_true(last == 3 * NODES - 1);
    assert_int_equal(frame[size - 1], 1); /* flag of node 5 */
    assert_int_equal(next_frame(&copy), 0);
}

/* What the last frame, of kind 2, says of `node`; INT16_MIN: nothing. Its nodes in `*out_count`. */
static int16_t told_of(uint32_t node, uint32_t *out_count)
{
    int16_t x = INT16_MIN;
    memcpy(out_count, frame + 4, 4);
    assert_int_equal(size, 8 + 10 * *out_count);
    for (uint32_t i = 0; i < *out_count; ++i) {
        uint32_t number = 0;
        memcpy(&number, frame + 8 + 4 * i, 4);
        if (number == node) {
            assert_true(x == INT16_MIN); /* once only */
            memcpy(&x, frame + 8 + 4 * *out_count + 6 * i, 2);
        }
    }
    return x;
}

/* One that takes every frame and one that takes none in between end with the same. */
TEST_WITH(a_slow_browser_gets_what_it_lacks_and_no_more, NULL, forget_body)
{
    ss_body_copy quick = {0}, slow = {0};
    uint32_t count = 0;
    take_chunk(1, 0, 6, 0, 4);
    next_frame(&quick);
    next_frame(&slow);
    for (int16_t x = 1; x <= 50; ++x) {
        take_delta(1, x % 2, x);
        assert_int_equal(next_frame(&quick), 2);
        assert_int_equal(told_of((uint32_t)x % 2, &count), x);
        assert_int_equal(count, 1);
    }
    take_delta(1, 1, 49); /* the server's refresh: nothing new */
    assert_int_equal(next_frame(&quick), 0);
    assert_int_equal(next_frame(&slow), 2);
    assert_int_equal(told_of(0, &count), 50);
    assert_int_equal(told_of(1, &count), 49);
    assert_int_equal(count, 2);
    assert_int_equal(next_frame(&slow), 0);
}

/* Against a copy of the counts for each browser, which is what a page has: random deltas, frames
 * taken now and then; the ends of the list and its middle are moved. */
TEST_WITH(frames_add_up_to_the_body_for_every_browser, NULL, forget_body)
{
    enum { BROWSERS = 3 };
    ss_body_copy copy[BROWSERS] = {{0}};
    int16_t now[NODES] = {0}, shown[BROWSERS][NODES] = {{0}};
    uint64_t random = 20260101;
    take_chunk(1, 0, 6, 0, 4);
    for (int b = 0; b < BROWSERS; ++b) {
        assert_int_equal(next_frame(&copy[b]), 1);
    }
    for (int k = 0; k < 3000; ++k) {
        const uint32_t node = ss_random_below(&random, NODES);
        now[node] = (int16_t)ss_random_below(&random, 4);
        take_delta(1, (int32_t)node, now[node]);
        const uint32_t b = ss_random_below(&random, BROWSERS);
        if (ss_random_below(&random, 1 + 8 * b) > 0 || next_frame(&copy[b]) == 0) {
            continue;
        }
        for (uint32_t n = 0; n < NODES; ++n) {
            uint32_t count = 0;
            const int16_t x = told_of(n, &count);
            shown[b][n] = x != INT16_MIN ? x : shown[b][n];
            assert_int_equal(shown[b][n], now[n]);
        }
    }
}

/* A server that was started again, of the same mesh: its body is at rest, and so is what an open
 * page shows. */
TEST_WITH(a_server_that_starts_again_has_no_old_dents, NULL, forget_body)
{
    ss_body_copy copy = {0};
    uint32_t count = 0;
    ss_body_begin_session(&body); /* before there is any */
    take_chunk(1, 0, 6, 0, 4);
    take_delta(1, 2, 9);
    assert_int_equal(next_frame(&copy), 1);
    assert_int_equal(next_frame(&copy), 2);
    ss_body_begin_session(&body);
    assert_int_equal(next_frame(&copy), 1);
    assert_int_equal(next_frame(&copy), 0);
    take_chunk(1, 0, 6, 0, 4); /* as it comes every two seconds */
    assert_int_equal(next_frame(&copy), 0);
    take_delta(1, 4, 3);
    assert_int_equal(next_frame(&copy), 2);
    assert_int_equal(told_of(2, &count), INT16_MIN);
    assert_int_equal(told_of(4, &count), 3);
}

TEST_WITH(a_late_browser_gets_the_body_and_its_displacements, NULL, forget_body)
{
    ss_body_copy copy = {0};
    take_chunk(1, 0, 6, 0, 4);
    take_delta(1, 2, 9);
    assert_int_equal(next_frame(&copy), 1);
    assert_int_equal(next_frame(&copy), 2);
    assert_int_equal(next_frame(&copy), 0);
}

TEST_WITH(another_body_starts_afresh, NULL, forget_body)
{
    ss_body_copy copy = {0};
    take_chunk(1, 0, 6, 0, 4);
    next_frame(&copy);
    take_delta(2, 0, 9); /* of a topology that is not known */
    assert_int_equal(next_frame(&copy), 0);
    take_chunk(2, 0, 6, 0, 4);
    assert_int_equal(next_frame(&copy), 1);
}

TEST_WITH(a_body_of_too_many_nodes_is_not_shown, NULL, forget_body)
{
    const softsim_topology_chunk chunk = {
        .topology = 1, .node_count = SS_BODY_MAX_NODES + 1, .scale = 1.0F};
    assert_false(ss_body_take_topology(&body, &chunk));
    take_delta(1, 0, 3);
    assert_int_equal(next_frame(&(ss_body_copy){0}), 0);
}

/* Bytes of memory that this process has touched. */
static int64_t resident_bytes(void)
{
    long long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%*d %lld", &pages), 1);
    fclose(file);
    return (int64_t)pages * sysconf(_SC_PAGESIZE);
}

/* Forged messages that announce the largest body and bring one node of it, one after the other; a
 * server that starts anew between them. */
TEST_WITH(a_body_costs_what_has_come_of_it, NULL, forget_body)
{
    enum { TIMES = 4, MOST = 48 << 20 };
    static const float rest[3] = {1.0F, 2.0F, 3.0F};
    static const int32_t file_node = 7;
    static const uint8_t flag = 1;
    const int64_t before = resident_bytes();
    void *between[TIMES]; /* of others: what is freed below does not go back to the system */
    for (int32_t k = 1; k <= TIMES; ++k) {
        const softsim_topology_chunk chunk = {.topology = k,
                                              .node_count = SS_BODY_MAX_NODES,
                                              .triangle_count = SS_BODY_MAX_TRIANGLES,
                                              .first_node = SS_BODY_MAX_NODES / 2,
                                              .node_chunk = 1,
                                              .scale = 1.0F,
                                              .file_node = &file_node,
                                              .node_flag = &flag,
                                              .rest = rest};
        assert_true(ss_body_take_topology(&body, &chunk));
        between[k - 1] = malloc(2000);
        take_delta(k, SS_BODY_MAX_NODES - 1, 9);
        ss_body_begin_session(&body);
        const int64_t cost = resident_bytes() - before;
        if (cost > MOST) {
            fail_msg("%.1f MB after %d messages", 1e-6 * (double)cost, k);
        }
    }
    for (int32_t k = 0; k < TIMES; ++k) {
        free(between[k]);
    }
    /* What was told before a session is forgotten all the same. */
    ss_body_copy copy = {0};
    take_chunk(TIMES + 1, 0, 6, 0, 4);
    take_delta(TIMES + 1, 2, 9);
    ss_body_begin_session(&body);
    assert_int_equal(next_frame(&copy), 1);
    assert_int_equal(next_frame(&copy), 0);
    take_delta(TIMES + 1, 2, 0);
    assert_int_equal(next_frame(&copy), 0);
}

TEST_WITH(a_field_goes_to_the_nodes_that_it_names, NULL, forget_body)
{
    static const int16_t value[] = {1, 2, 3};
    ss_body_copy copy = {0};
    const softsim_mesh_field field = {.topology = 1,
                                      .first_node = 3,
                                      .count = 3,
                                      .name = "energy",
                                      .unit = "J/m^3",
                                      .high = 2.0F,
                                      .value = value};
    softsim_mesh_field beyond = field;
    beyond.first_node = 4;
    take_chunk(1, 0, 6, 0, 4);
    next_frame(&copy);
    ss_body_take_field(&body, &beyond);
    assert_int_equal(next_frame(&copy), 0);
    ss_body_take_field(&body, &field);
    assert_int_equal(next_frame(&copy), 3);
    assert_int_equal(size, 80 + 2 * NODES);
    assert_string_equal((const char *)frame + 16, "energy");
    assert_string_equal((const char *)frame + 48, "J/m^3");
    int16_t last = 0;
    memcpy(&last, frame + size - 2, 2);
    assert_int_equal(last, 3);
}

/* A browser whose link takes one frame between two deltas. */
TEST_WITH(a_slow_browser_gets_fields_too, NULL, forget_body)
{
    static const int16_t value[] = {1};
    const softsim_mesh_field field = {
        .topology = 1, .count = 1, .name = "energy", .unit = "J/m^3", .value = value};
    ss_body_copy copy = {0};
    take_chunk(1, 0, 6, 0, 4);
    next_frame(&copy);
    for (int16_t k = 0; k < 10; ++k) {
        take_delta(1, 0, (int16_t)(k + 1));
        ss_body_take_field(&body, &field);
        assert_int_equal(next_frame(&copy), k % 2 == 0 ? 2 : 3);
    }
}

/* ---- the mouse ---- */

static const int64_t MS = 1000000;

static ss_mouse_aim aim_at(double x)
{
    return (ss_mouse_aim){.position = {x, 0, 0}, .orientation = {1, 0, 0, 0}};
}

/* However the mouse jumps, the probe goes no further than a server takes, and no faster than a
 * meter a second; it arrives, and stands. */
TEST(the_probe_follows_the_mouse_without_a_jump)
{
    ss_mouse mouse = {0};
    softsim_pose pose = {0}, last = {0};
    int64_t now_ns = 1000 * MS;
    ss_mouse_aim aim = aim_at(0.0);
    assert_true(ss_mouse_aim_at(&mouse, &aim, now_ns));
    assert_true(ss_mouse_move(&mouse, now_ns, &last));
    assert_true(ss_norm3(last.position) == 0.0);
    for (int i = 0; i < 250; ++i) {
        if (i % 4 == 0) {
            aim = aim_at(i < 100 ? 0.2 : -0.1);
            assert_true(ss_mouse_aim_at(&mouse, &aim, now_ns));
        }
        now_ns += 4 * MS;
        assert_true(ss_mouse_move(&mouse, now_ns, &pose));
        double way[3];
        ss_sub3(way, pose.position, last.position);
        assert_true(ss_norm3(way) <= 0.004 + 1e-12);
        assert_true(ss_norm3(pose.velocity) <= 10.0);
        last = pose;
    }
    assert_true(fabs(last.position[0] + 0.1) < 1e-4);
}

/* The mouse has been at 0 and is on its way to x (m); returns the time, in ns. */
static int64_t send_mouse(ss_mouse *mouse, double x, softsim_pose *pose)
{
    const int64_t now_ns = 1000 * MS;
    ss_mouse_aim aim = aim_at(0.0);
    ss_mouse_aim_at(mouse, &aim, now_ns);
    ss_mouse_move(mouse, now_ns, pose);
    aim = aim_at(x);
    ss_mouse_aim_at(mouse, &aim, now_ns);
    return now_ns;
}

/* A server that takes small steps only, of which three in a row are lost. */
TEST(no_pose_is_further_than_the_server_takes)
{
    enum { LOST = 3, STEPS = 200 };
    double x[STEPS];
    ss_mouse mouse = {.max_jump_m = 0.002};
    softsim_pose pose = {0};
    int64_t now_ns = send_mouse(&mouse, 0.05, &pose);
    const ss_mouse_aim aim = aim_at(0.05);
    for (int i = 0; i < STEPS; ++i) {
        ss_mouse_aim_at(&mouse, &aim, now_ns);
        now_ns += (i % 7 == 0 ? 60 : 4) * MS; /* now and then its thread is held up */
        assert_true(ss_mouse_move(&mouse, now_ns, &pose));
        x[i] = pose.position[0];
        assert_true(fabs(x[i] - (i > LOST ? x[i - LOST - 1] : 0.0)) <= mouse.max_jump_m + 1e-12);
    }
    assert_true(fabs(x[STEPS - 1] - 0.05) < 1e-6);
}

/* The closed form of equal roots, at steps of any length. */
TEST(the_way_does_not_depend_on_the_period)
{
    double end[2];
    for (int k = 0; k < 2; ++k) {
        ss_mouse mouse = {0};
        softsim_pose pose = {0};
        int64_t now_ns = send_mouse(&mouse, 0.01, &pose);
        for (int i = 0; i < (k == 0 ? 40 : 10); ++i) {
            now_ns += (k == 0 ? 1 : 4) * MS;
            ss_mouse_move(&mouse, now_ns, &pose);
        }
        end[k] = pose.position[0];
    }
    assert_true(end[0] > 0.004 && fabs(end[0] - end[1]) < 1e-9);
}

TEST(a_place_out_of_reach_is_approached_by_silence)
{
    ss_mouse mouse = {0};
    softsim_pose pose = {0};
    int64_t now_ns = 1000 * MS;
    ss_mouse_aim aim = aim_at(0.0);
    ss_mouse_aim_at(&mouse, &aim, now_ns);
    assert_true(ss_mouse_move(&mouse, now_ns, &pose));
    ss_mouse_drop(&mouse);
    aim = aim_at(0.5);
    ss_mouse_aim_at(&mouse, &aim, now_ns);
    assert_false(ss_mouse_move(&mouse, now_ns + 69 * MS, &pose));
    assert_true(ss_mouse_move(&mouse, now_ns + 70 * MS, &pose));
    assert_true(pose.position[0] == 0.5);
}

TEST(a_mouse_that_is_not_heard_of_lets_go)
{
    ss_mouse mouse = {0};
    softsim_pose pose = {0};
    const ss_mouse_aim aim = aim_at(0.0);
    ss_mouse_aim_at(&mouse, &aim, 1000 * MS);
    assert_true(ss_mouse_move(&mouse, 2500 * MS, &pose));
    assert_false(ss_mouse_move(&mouse, 2501 * MS, &pose));
    assert_false(mouse.is_held);
}

TEST(what_is_no_place_is_not_aimed_at)
{
    const ss_mouse_aim bad[] = {{.position = {(double)NAN, 0, 0}, .orientation = {1, 0, 0, 0}},
                                {.position = {0, (double)INFINITY, 0}, .orientation = {1, 0, 0, 0}},
                                {.position = {0, 0, 100.5}, .orientation = {1, 0, 0, 0}},
                                {.orientation = {0, 0, 0, 0}},
                                {.orientation = {1, 0.1, 0, 0}},
                                {.orientation = {(double)NAN, 0, 0, 0}}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        ss_mouse mouse = {0};
        assert_false(ss_mouse_aim_at(&mouse, &bad[i], 1000 * MS));
        assert_false(mouse.is_held);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
