/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * net/publisher: the mesh on the wire can be put together again from its messages alone, follows
 * the displacements within half a count, heals, and keeps its cap. Over memq://, in one process,
 * with time given by hand.
 */
#include "common/test.h"

#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>

#include "net/net.h"
#include "net/wire.h"
#include "rt/random.h"
#include "softsim_mesh_delta_t.h"
#include "softsim_mesh_field_t.h"
#include "softsim_mesh_topology_t.h"

static const int64_t MS = 1000000;
static const double UNKNOWN = (double)NAN;

enum { SIDE = 90, NODES = SIDE * SIDE, TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1), MAX_SENT = 20000 };

/* A square sheet, and a reader that knows nothing but the messages. */
typedef struct sheet {
    double rest[NODES][3];
    int32_t triangle[TRIANGLES][3];
    int32_t file_node[NODES];
    uint8_t fixed[NODES];
    float displacement[NODES][3];
    ss_publish_mesh mesh;
    ss_publisher *publisher;
    int64_t now_ns;
    /* What was read. */
    int32_t topology, topology_messages, delta_messages, topology_seq, delta_seq;
    float scale;
    bool has_node[NODES], has_triangle[TRIANGLES];
    float read_rest[NODES][3];
    int32_t read_triangle[TRIANGLES][3], read_file_node[NODES];
    uint8_t read_flag[NODES];
    int16_t read[NODES][3];
    int64_t read_ns[NODES];
    int32_t read_seq[NODES];
    int32_t last_count;
    int64_t last_step;
    bool is_deaf;
    /* When how much came. */
    int sent_count;
    int64_t sent_ns[MAX_SENT];
    int sent_size[MAX_SENT];
} sheet;

static int note_size(sheet *s, const lcm_recv_buf_t *message)
{
    assert_true(message->data_size <= SS_WIRE_MAX_MESSAGE);
    assert_true(s->sent_count < MAX_SENT);
    s->sent_ns[s->sent_count] = s->now_ns;
    s->sent_size[s->sent_count++] = (int)message->data_size;
    return (int)message->data_size;
}

static void read_topology(const lcm_recv_buf_t *message, const char *channel, void *user)
{
    (void)channel;
    sheet *s = user;
    softsim_mesh_topology_t t;
    const int size = note_size(s, message);
    assert_int_equal(softsim_mesh_topology_t_decode(message->data, 0, size, &t), size);
    assert_int_equal(t.node_count, NODES);
    assert_int_equal(t.triangle_count, TRIANGLES);
    assert_int_equal(t.rest_count, 3 * t.node_chunk);
    assert_int_equal(t.triangle_index_count % 3, 0);
    assert_true(t.first_node + t.node_chunk <= NODES);
    assert_true(t.first_triangle + t.triangle_index_count / 3 <= TRIANGLES);
    assert_true(t.node_chunk + t.triangle_index_count > 0);
    assert_int_equal(t.seq, s->topology_seq + 1);
    assert_true(s->topology == 0 || s->topology == t.topology);
    s->topology_seq = t.seq;
    s->topology = t.topology;
    s->scale = t.scale;
    for (int32_t i = 0; i < t.node_chunk; ++i) {
        const int32_t node = t.first_node + i;
        s->has_node[node] = true;
        memcpy(s->read_rest[node], t.rest + 3 * i, sizeof s->read_rest[node]);
        s->read_file_node[node] = t.file_node[i];
        s->read_flag[node] = t.node_flag[i];
    }
    for (int32_t i = 0; i < t.triangle_index_count / 3; ++i) {
        s->has_triangle[t.first_triangle + i] = true;
        memcpy(s->read_triangle[t.first_triangle + i], t.triangle + 3 * i, sizeof(int32_t[3]));
    }
    s->topology_messages += 1;
    softsim_mesh_topology_t_decode_cleanup(&t);
}

static void read_delta(const lcm_recv_buf_t *message, const char *channel, void *user)
{
    (void)channel;
    sheet *s = user;
    softsim_mesh_delta_t d;
    const int size = note_size(s, message);
    assert_int_equal(softsim_mesh_delta_t_decode(message->data, 0, size, &d), size);
    assert_true(d.count > 0);
    assert_int_equal(d.displacement_count, 3 * d.count);
    assert_int_equal(d.seq, s->delta_seq + 1);
    s->delta_seq = d.seq;
    s->last_count = d.count;
    s->last_step = d.step;
    s->delta_messages += 1;
    for (int32_t i = 0; i < d.count; ++i) {
        assert_in_range(d.node[i], 0, NODES - 1);
        assert_int_not_equal(s->read_seq[d.node[i]], d.seq); /* once a message */
        s->read_seq[d.node[i]] = d.seq;
        if (s->is_deaf) {
            continue;
        }
        memcpy(s->read[d.node[i]], d.displacement + 3 * i, sizeof s->read[0]);
        s->read_ns[d.node[i]] = s->now_ns;
    }
    softsim_mesh_delta_t_decode_cleanup(&d);
}

static sheet *sheet_make(double max_bytes_per_s)
{
    sheet *s = calloc(1, sizeof *s);
    for (int32_t i = 0; i < NODES; ++i) {
        s->rest[i][0] = 0.001 * (i % SIDE);
        s->rest[i][1] = 0.001 * (i / SIDE);
        s->file_node[i] = 3 * i + 1;
        s->fixed[i] = i % SIDE == 0;
    }
    int32_t t = 0;
    for (int32_t y = 0; y + 1 < SIDE; ++y) {
        for (int32_t x = 0; x + 1 < SIDE; ++x) {
            const int32_t a = y * SIDE + x;
            const int32_t pair[2][3] = {{a, a + 1, a + SIDE}, {a + 1, a + SIDE + 1, a + SIDE}};
            memcpy(s->triangle[t], pair, sizeof pair);
            t += 2;
        }
    }
    s->mesh = (ss_publish_mesh){.node_count = NODES,
                                .triangle_count = TRIANGLES,
                                .rest = (const double(*)[3])s->rest,
                                .triangle = (const int32_t(*)[3])s->triangle,
                                .file_node = s->file_node,
                                .fixed = s->fixed,
                                .diagonal = 0.001 * (SIDE - 1) * sqrt(2.0)};
    const ss_publisher_config config = {
        .lcm_url = "memq://", .prefix = "M", .max_bytes_per_s = max_bytes_per_s};
    softsim_error error = {.status = SOFTSIM_OK};
    assert_int_equal(ss_publisher_open(&config, &s->mesh, &s->publisher, &error), SOFTSIM_OK);
    lcm_subscribe(ss_publisher_lcm(s->publisher), "M_MESH_TOPOLOGY", read_topology, s);
    lcm_subscribe(ss_publisher_lcm(s->publisher), "M_MESH_DELTA", read_delta, s);
    s->now_ns = 12345 * MS;
    return s;
}

static void sheet_free(sheet *s)
{
    ss_publisher_close(&s->publisher);
    assert_null(s->publisher);
    free(s);
}

/* One period of a 60 Hz publish thread. */
static void sheet_send(sheet *s, int64_t step, const float *displacement)
{
    const int before = s->sent_count;
    ss_publisher_send(s->publisher, s->now_ns, step, displacement);
    lcm_t *lcm = ss_publisher_lcm(s->publisher);
    struct pollfd waiting = {.fd = lcm_get_fileno(lcm), .events = POLLIN};
    while (poll(&waiting, 1, 0) > 0) {
        assert_int_equal(lcm_handle(lcm), 0);
    }
    assert_true(s->sent_count - before <= 2);
    s->now_ns += 16666667;
}

static double sheet_error(const sheet *s)
{
    double worst = 0.0;
    for (int32_t i = 0; i < NODES; ++i) {
        for (int d = 0; d < 3; ++d) {
            const double read = (double)s->scale * s->read[i][d];
            worst = fmax(worst, fabs(read - (double)s->displacement[i][d]));
        }
    }
    return worst / (double)s->scale;
}

static void displace_all(sheet *s, uint64_t *seed, double size)
{
    for (int32_t i = 0; i < NODES; ++i) {
        for (int d = 0; d < 3; ++d) {
            s->displacement[i][d] = (float)(size * (ss_random_unit(seed) - 0.5));
        }
    }
}

/* All of it displaced, and told. */
static sheet *sheet_make_moved(uint64_t *seed)
{
    sheet *s = sheet_make(8e6);
    displace_all(s, seed, 0.1);
    for (int i = 0; i < 20; ++i) {
        sheet_send(s, 1, &s->displacement[0][0]);
    }
    return s;
}

static void check_reassembled(const sheet *s)
{
    for (int32_t i = 0; i < NODES; ++i) {
        assert_true(s->has_node[i]);
        assert_int_equal(s->read_file_node[i], s->file_node[i]);
        assert_int_equal(s->read_flag[i], s->fixed[i]);
        for (int d = 0; d < 3; ++d) {
            assert_true(s->read_rest[i][d] == (float)s->rest[i][d]);
        }
    }
    for (int32_t i = 0; i < TRIANGLES; ++i) {
        assert_true(s->has_triangle[i]);
    }
    assert_memory_equal(s->read_triangle, s->triangle, sizeof s->triangle);
    assert_true(fabs((double)s->scale * 16384.0 / s->mesh.diagonal - 1.0) < 1e-6);
}

TEST(topology_chunks_make_the_mesh_and_come_every_two_seconds)
{
    sheet *s = sheet_make(8e6);
    for (int i = 0; i < 10; ++i) {
        sheet_send(s, 0, NULL);
    }
    check_reassembled(s);
    const int32_t chunks = s->topology_messages;
    assert_true(chunks >= (NODES * 17 + TRIANGLES * 12) / 65000);
    for (int i = 0; i < 100; ++i) {
        sheet_send(s, 0, NULL);
    }
    assert_int_equal(s->topology_messages, chunks);
    memset(s->has_node, 0, sizeof s->has_node);
    memset(s->has_triangle, 0, sizeof s->has_triangle);
    for (int i = 0; i < 20; ++i) {
        sheet_send(s, 0, NULL);
    }
    assert_int_equal(s->topology_messages, 2 * chunks);
    check_reassembled(s);
    /* On command at once, also in the middle of a round. */
    ss_publisher_refresh(s->publisher);
    sheet_send(s, 0, NULL);
    ss_publisher_refresh(s->publisher);
    memset(s->has_node, 0, sizeof s->has_node);
    memset(s->has_triangle, 0, sizeof s->has_triangle);
    for (int i = 0; i < 10; ++i) {
        sheet_send(s, 0, NULL);
    }
    check_reassembled(s);
    assert_int_equal(s->delta_messages, 0); /* nothing ever moved */
    assert_false(ss_publisher_is_capped(s->publisher));
    int64_t total = 0;
    for (int i = 0; i < s->sent_count; ++i) {
        total += s->sent_size[i];
    }
    assert_int_equal(ss_publisher_bytes(s->publisher), total);
    sheet_free(s);
}

TEST(the_topology_number_belongs_to_the_mesh)
{
    sheet *a = sheet_make(8e6);
    sheet *b = sheet_make(8e6);
    sheet_send(a, 0, NULL);
    sheet_send(b, 0, NULL);
    assert_true(a->topology > 0);
    assert_int_equal(a->topology, b->topology);
    sheet_free(a);
    sheet_free(b);
}

TEST(deltas_follow_the_displacements_within_half_a_count)
{
    sheet *s = sheet_make(8e6);
    uint64_t seed = 3;
    for (int i = 0; i < 10; ++i) {
        sheet_send(s, 0, NULL);
    }
    /* A patch moves; what is read is right at every step. */
    for (int64_t step = 1; step <= 100; ++step) {
        for (int i = 0; i < 300; ++i) {
            const int32_t node = (int32_t)(ss_random_unit(&seed) * NODES);
            for (int d = 0; d < 3; ++d) {
                s->displacement[node][d] = (float)(0.02 * (ss_random_unit(&seed) - 0.5));
            }
        }
        sheet_send(s, step, &s->displacement[0][0]);
        assert_int_equal(s->last_step, step);
        assert_true(sheet_error(s) <= 0.5 + 1e-3);
    }
    /* Everything moves: two messages hold it all, one when the topology takes its turn. */
    for (int64_t step = 101; step <= 300; ++step) {
        displace_all(s, &seed, 0.1);
        sheet_send(s, step, &s->displacement[0][0]);
        sheet_send(s, step, NULL);
        sheet_send(s, step, NULL);
        assert_true(sheet_error(s) <= 0.5 + 1e-3);
    }
    sheet_free(s);
}

static int16_t field_read[NODES];
static float field_low, field_high;
static int field_messages;

static void read_field(const lcm_recv_buf_t *message, const char *channel, void *user)
{
    (void)channel;
    sheet *s = user;
    softsim_mesh_field_t f;
    const int size = note_size(s, message);
    assert_int_equal(softsim_mesh_field_t_decode(message->data, 0, size, &f), size);
    assert_string_equal(f.name, "pressure");
    assert_string_equal(f.unit, "Pa");
    assert_true(f.first_node >= 0 && f.count > 0 && f.first_node + f.count <= NODES);
    memcpy(field_read + f.first_node, f.value, (size_t)f.count * sizeof *f.value);
    field_low = f.low;
    field_high = f.high;
    ++field_messages;
    softsim_mesh_field_t_decode_cleanup(&f);
}

/* Each value within half a count of the range, which holds them all; one that stands still comes
 * once a second; what is not finite is 0. */
TEST(a_field_follows_its_values)
{
    static float value[NODES];
    sheet *s = sheet_make(1e7);
    lcm_subscribe(ss_publisher_lcm(s->publisher), "M_MESH_FIELD", read_field, s);
    for (int round = 0; round < 3; ++round) {
        for (int32_t i = 0; i < NODES; ++i) {
            value[i] = (float)(round + 1) * ((float)i - 4000.0F);
        }
        value[7] = round == 1 ? (float)UNKNOWN : 0.0F;
        ss_publisher_set_field(s->publisher, s->now_ns, round, "pressure", "Pa", value);
        for (int i = 0; i < 5; ++i) {
            sheet_send(s, 0, NULL);
        }
        const float count = (field_high - field_low) / 65534.0F;
        assert_true(field_high >= 4099.0F * (float)(round + 1) && field_low == -field_high);
        for (int32_t i = 0; i < NODES; ++i) {
            const float wanted = i == 7 ? 0.0F : value[i];
            const float read = ((float)field_read[i] / 32767.0F) * field_high;
            assert_true(fabsf(read - wanted) <= 0.6F * count);
        }
    }
    field_messages = 0;
    for (int i = 0; i < 200; ++i) { /* 3.2 s */
        ss_publisher_set_field(s->publisher, s->now_ns, 3, "pressure", "Pa", value);
        sheet_send(s, 0, NULL);
    }
    assert_in_range(field_messages, 2, 4);
    sheet_free(s);
}

TEST(only_what_moved_is_sent)
{
    sheet *s = sheet_make(8e6);
    for (int i = 0; i < 10; ++i) {
        sheet_send(s, 0, &s->displacement[0][0]);
    }
    assert_int_equal(s->delta_messages, 0);
    const float scale = s->scale;
    s->displacement[77][1] = 0.49f * scale; /* less than half a count */
    sheet_send(s, 1, &s->displacement[0][0]);
    assert_int_equal(s->delta_messages, 0);
    s->displacement[77][1] = 0.51f * scale;
    sheet_send(s, 2, &s->displacement[0][0]);
    assert_int_equal(s->delta_messages, 1);
    assert_int_equal(s->last_count, 1);
    assert_int_equal(s->read[77][1], 1);
    sheet_send(s, 3, &s->displacement[0][0]);
    assert_int_equal(s->delta_messages, 1);
    sheet_free(s);
}

/* All but one still for `seconds`, topology rounds between: each was told in the last `most` s. */
static void expect_all_told(sheet *s, int seconds, int64_t most, bool moves)
{
    for (int i = 0; i < 60 * seconds; ++i) {
        for (int32_t n = 0; n < NODES; ++n) {
            assert_true(s->now_ns - s->read_ns[n] <= 1000 * MS * most);
        }
        s->displacement[0][0] += moves ? 2.0f * s->scale : 0.0f;
        sheet_send(s, 1, &s->displacement[0][0]);
        assert_false(ss_publisher_is_capped(s->publisher));
    }
}

TEST(every_displaced_node_comes_again_within_a_second)
{
    uint64_t seed = 4;
    sheet *s = sheet_make_moved(&seed);
    assert_true(sheet_error(s) <= 0.5 + 1e-3);
    expect_all_told(s, 4, 1, true);
    sheet_free(s);
}

/* A reader who joins then has all within ten seconds, or at once by a refresh; beside the rounds,
 * each with every displaced node, nothing goes out. */
TEST(at_rest_mesh_and_displaced_nodes_come_every_ten_seconds)
{
    uint64_t seed = 6;
    sheet *s = sheet_make_moved(&seed);
    expect_all_told(s, 5, 1 + 3, false);
    const int64_t before = ss_publisher_bytes(s->publisher);
    expect_all_told(s, 30, 10, false);
    const int64_t in_rounds = ss_publisher_bytes(s->publisher) - before;
    memset(s->read, 0, sizeof s->read);
    const int64_t asked = ss_publisher_bytes(s->publisher);
    ss_publisher_refresh(s->publisher);
    for (int i = 0; i < 10; ++i) {
        sheet_send(s, 1, NULL);
    }
    const int64_t round = ss_publisher_bytes(s->publisher) - asked;
    print_message("%lld bytes in 30 s, %lld a round\n", (long long)in_rounds, (long long)round);
    assert_true(sheet_error(s) <= 0.5 + 1e-3);
    assert_true(in_rounds >= 2 * round && in_rounds <= 4 * round);
    /* What moves again is told as ever. */
    expect_all_told(s, 2, 10, true);
    expect_all_told(s, 3, 1, true);
    sheet_free(s);
}

TEST(a_lost_delta_heals_also_where_the_tissue_is_at_rest_again)
{
    uint64_t seed = 5;
    sheet *s = sheet_make_moved(&seed);
    s->is_deaf = true;
    displace_all(s, &seed, 0.1);
    memset(s->displacement, 0, sizeof s->displacement / 2);
    for (int i = 0; i < 60; ++i) {
        sheet_send(s, 2, &s->displacement[0][0]);
    }
    s->is_deaf = false;
    assert_true(sheet_error(s) > 100.0);
    for (int i = 0; i < 60; ++i) {
        sheet_send(s, 3, NULL);
    }
    assert_true(sheet_error(s) <= 0.5 + 1e-3);
    /* On command sooner: a reader that joins now. */
    memset(s->read, 0, sizeof s->read);
    ss_publisher_refresh(s->publisher);
    for (int i = 0; i < 10; ++i) {
        s->displacement[100 * (i + 40)][0] += 10.0f * s->scale; /* the sweep meets moving nodes */
        sheet_send(s, 4 + i, &s->displacement[0][0]);
    }
    assert_true(sheet_error(s) <= 0.5 + 1e-3);
    sheet_free(s);
}

static void check_cap(const sheet *s, double cap)
{
    int first = 0;
    int64_t in_second = 0;
    for (int i = 0; i < s->sent_count; ++i) {
        in_second += s->sent_size[i];
        while (s->sent_ns[i] - s->sent_ns[first] >= 1000 * MS) {
            in_second -= s->sent_size[first++];
        }
        assert_true((double)in_second <= cap);
    }
}

TEST(no_second_holds_more_than_the_cap_and_all_gets_through)
{
    const double cap[] = {1e5, 1e6, 8e6};
    for (size_t c = 0; c < sizeof cap / sizeof cap[0]; ++c) {
        sheet *s = sheet_make(cap[c]);
        uint64_t seed = 6;
        bool was_capped = false;
        int64_t step = 0;
        for (int i = 0; i < 600; ++i) {
            displace_all(s, &seed, 0.1);
            sheet_send(s, ++step, &s->displacement[0][0]);
            was_capped |= ss_publisher_is_capped(s->publisher);
        }
        check_cap(s, cap[c]);
        /* Sweep and topology alone need 220,000 B/s. */
        assert_int_equal(was_capped, cap[c] < 2.2e5);
        /* The rate is used, not only kept: within 25 % of the cap or of what two messages a call
         * allow. */
        const double wanted = fmin(cap[c], 60.0 * 100000.0);
        assert_true((double)ss_publisher_bytes(s->publisher) > 0.75 * wanted * 10.0);
        assert_true(s->topology_messages > 3);
        /* Neither nodes nor chunks starve. */
        const int calls = (int)(60.0 * 3e6 / cap[c]) + 60;
        memset(s->read, 0, sizeof s->read);
        memset(s->has_node, 0, sizeof s->has_node);
        memset(s->has_triangle, 0, sizeof s->has_triangle);
        ss_publisher_refresh(s->publisher);
        for (int i = 0; i < calls; ++i) {
            sheet_send(s, step, NULL);
        }
        check_cap(s, cap[c]);
        check_reassembled(s);
        assert_true(sheet_error(s) <= 0.5 + 1e-3);
        sheet_free(s);
    }
}

TEST(the_cap_can_be_changed)
{
    sheet *s = sheet_make(8e6);
    uint64_t seed = 8;
    int64_t step = 0;
    displace_all(s, &seed, 0.1);
    sheet_send(s, ++step, &s->displacement[0][0]);
    const double cap[] = {2e5, UNKNOWN, -1.0, 5e4};
    for (size_t c = 0; c < sizeof cap / sizeof cap[0]; ++c) {
        ss_publisher_set_max_bytes(s->publisher, cap[c]);
        s->now_ns += 2000 * MS;
        s->sent_count = 0;
        for (int i = 0; i < 200; ++i) {
            displace_all(s, &seed, 0.1);
            sheet_send(s, ++step, &s->displacement[0][0]);
        }
        check_cap(s, cap[c] > 1000.0 ? cap[c] : 1000.0);
        assert_true(s->sent_count > 0);
    }
    sheet_free(s);
}

TEST(displacements_beyond_the_scale_are_clamped_and_told)
{
    sheet *s = sheet_make(8e6);
    for (int i = 0; i < 10; ++i) {
        sheet_send(s, 0, &s->displacement[0][0]);
    }
    s->displacement[5][0] = (float)(1.99 * s->mesh.diagonal);
    sheet_send(s, 1, &s->displacement[0][0]);
    assert_false(ss_publisher_is_clamping(s->publisher));
    assert_true(sheet_error(s) <= 0.5 + 1e-2);
    s->displacement[5][1] = (float)(-2.5 * s->mesh.diagonal);
    s->displacement[5][2] = 1e30f;
    sheet_send(s, 2, &s->displacement[0][0]);
    assert_true(ss_publisher_is_clamping(s->publisher));
    assert_int_equal(s->read[5][1], -32767);
    assert_int_equal(s->read[5][2], 32767);
    /* Not a number: the node stays where it was last. */
    s->displacement[5][0] = (float)UNKNOWN;
    s->displacement[5][1] = s->displacement[5][2] = 0.0f;
    sheet_send(s, 3, &s->displacement[0][0]);
    assert_int_equal(s->read[5][1], -32767);
    s->displacement[5][0] = 0.0f;
    sheet_send(s, 4, &s->displacement[0][0]);
    assert_false(ss_publisher_is_clamping(s->publisher));
    assert_int_equal(s->read[5][1], 0);
    sheet_free(s);
}

TEST(a_mesh_without_size_is_refused)
{
    const double rest[1][3] = {{0, 0, 0}};
    const double bad[] = {0.0, -1.0, UNKNOWN, HUGE_VAL, 1e-300};
    const ss_publisher_config config = {
        .lcm_url = "memq://", .prefix = "M", .max_bytes_per_s = 1e6};
    ss_publisher *publisher = NULL;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        softsim_error error = {.status = SOFTSIM_OK};
        const ss_publish_mesh mesh = {.node_count = 1, .rest = rest, .diagonal = bad[i]};
        assert_int_equal(ss_publisher_open(&config, &mesh, &publisher, &error),
                         SOFTSIM_ERROR_ARGUMENT);
        assert_null(publisher);
    }
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
