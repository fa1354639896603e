/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The mesh on the wire: the surface at rest in topology chunks, its displacements in deltas.
 *
 * Displacements are absolute, in counts of s = diagonal / 16384: q = round(u / s), clamped to
 * +-32767, that is two diagonals. `latest` holds q of the newest state, `sent` what went out last;
 * a node is due when they differ, so that a reader who got everything is never off by more than
 * half a count. Against loss, and for readers who join late, a cursor sweeps all nodes every
 * 0.8 s and sends again those that were ever displaced, back at rest or not: nothing needs a
 * handshake. The topology goes out every 2 s in chunks that say which nodes and triangles they
 * hold; its number is a hash of the mesh, so that a restarted server continues the same one. Where
 * no count has changed for 3 s, and the sweep has passed three times since, only a round every 10 s
 * goes out, and the sweep and the field once with it.
 *
 * What limits it: a message is one UDP packet (65,000 B); at most two messages a call, which
 * a stock receive buffer of 212,992 B takes even when nobody reads in between; and a token bucket
 * of depth B = min(cap / 10, two messages) filled at cap - B per second, so that no second holds
 * more than the cap. Topology and deltas take turns; one that has to wait for tokens keeps its
 * turn, so that neither starves. In a delta the sweep may take half the room until every changed
 * node had its place. Rejected: whole frames, which at 60 Hz are a hundred times the bytes of what
 * a tool moves, and deltas against the last frame, which a lost message would break.
 */
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "net/net.h"
#include "net/wire.h"
#include "rt/each.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "softsim_mesh_delta_t.h"
#include "softsim_mesh_field_t.h"
#include "softsim_mesh_topology_t.h"

enum {
    TOPOLOGY_HEADER = 8 + 8 + 9 * 4 + 4, /* bytes, hash and lengths included */
    NODE_BYTES = 4 + 1 + 3 * 4,
    TRIANGLE_BYTES = 3 * 4,
    DELTA_HEADER = 8 + 2 * 8 + 4 * 4,
    MOVED_BYTES = 4 + 3 * 2,
    MAX_CHUNK_NODES = (SS_WIRE_MAX_MESSAGE - TOPOLOGY_HEADER) / NODE_BYTES,
    MAX_MOVED = (SS_WIRE_MAX_MESSAGE - DELTA_HEADER) / MOVED_BYTES,
    FIELD_HEADER = 8 + 2 * 8 + 4 * 4 + 2 * (4 + 16) + 2 * 4, /* its texts at their longest */
    MESSAGES_PER_CALL = 2,
    MAX_COUNT = 32767
};
static const double COUNTS_PER_DIAGONAL = 16384.0;
static const double SWEEP_S = 0.8; /* leaves 0.2 s of the promised 1 s for the caller's period */
static const double LATE_S = 0.2;
static const float FIELD_FADE = 0.98F;             /* of the range, a message */
static const int64_t FIELD_PERIOD_NS = 1000000000; /* of one that does not change */
static const int64_t TOPOLOGY_PERIOD_NS = 2000000000;
/* A body at rest: since when nothing has changed, and its rounds, less the caller's period. */
static const int64_t REST_NS = 3000000000;
static const int64_t REST_PERIOD_NS = 9700000000;
static const double MIN_BYTES_PER_S = 1000.0;

typedef enum send_result { SENT, NOTHING_DUE, OUT_OF_TOKENS } send_result;

struct ss_publisher {
    lcm_t *lcm;
    char topology_channel[SS_WIRE_CHANNEL_SIZE];
    char delta_channel[SS_WIRE_CHANNEL_SIZE];
    ss_publish_mesh mesh;
    int32_t topology;
    float scale; /* m per count, as sent */

    /* Rate: token bucket. */
    double tokens, depth, fill_per_s; /* bytes */
    int32_t message_limit;            /* bytes, <= depth */
    bool has_started;
    int64_t last_ns;
    bool is_changed;    /* a count, since the last call; or all is asked for */
    int64_t changed_ns; /* when that was last */
    bool wants_field;   /* to go out once more, with the round of a body at rest */

    /* Topology round. */
    bool is_round_open, is_round_wanted, is_topology_turn;
    int64_t round_start_ns;
    int32_t next_node, next_triangle;
    int32_t topology_seq;

    /* Deltas. */
    int16_t (*latest)[3];
    int16_t (*sent)[3];
    uint8_t *is_swept;    /* was displaced once */
    uint32_t *in_message; /* number of the last message that holds the node */
    int32_t changed_cursor, sweep_cursor;
    double sweep_due; /* nodes that the sweep has yet to pass */
    int64_t sweep_kept_ns;
    int64_t step;
    int32_t delta_seq;

    /* Field: the counts of the newest one, taken at the first. */
    int16_t *field;
    int32_t field_cursor; /* of nodes that went out */
    int64_t field_step, field_ns;
    float field_reach; /* the largest size lately */
    bool is_field_signed, is_field_turn;
    char field_name[16], field_unit[16];
    int32_t field_seq;
    char field_channel[SS_WIRE_CHANNEL_SIZE];

    /* Message being built. */
    int32_t moved_count;
    int32_t node[MAX_MOVED];
    int16_t displacement[MAX_MOVED][3];
    int32_t chunk_file_node[MAX_CHUNK_NODES];
    uint8_t chunk_flag[MAX_CHUNK_NODES];
    float chunk_rest[MAX_CHUNK_NODES][3];
    uint8_t buffer[SS_WIRE_MAX_MESSAGE];

    /* Statistics, read by any thread: relaxed. */
    atomic_int_least64_t bytes;
    atomic_bool is_clamping;
    atomic_bool is_capped;
};

/* ---- rate ---- */

/* Has no count changed for a while? */
static bool is_resting(const ss_publisher *publisher, int64_t now_ns)
{
    return now_ns - publisher->changed_ns >= REST_NS;
}

void ss_publisher_set_max_bytes(ss_publisher *publisher, double max_bytes_per_s)
{
    const double cap = fmin(fmax(max_bytes_per_s, MIN_BYTES_PER_S), 1e12); /* NaN: the least */
    publisher->depth = fmin(cap / 10.0, (double)(MESSAGES_PER_CALL * SS_WIRE_MAX_MESSAGE));
    publisher->fill_per_s = cap - publisher->depth;
    publisher->message_limit = (int32_t)fmin(publisher->depth, SS_WIRE_MAX_MESSAGE);
    publisher->tokens = fmin(publisher->tokens, publisher->depth);
}

static void publish(ss_publisher *publisher, const char *channel, int size)
{
    publisher->tokens -= size;
    if (size > 0 && lcm_publish(publisher->lcm, channel, publisher->buffer, (unsigned)size) == 0) {
        atomic_fetch_add_explicit(&publisher->bytes, size, memory_order_relaxed);
    }
}

/* ---- topology ---- */

static void fill_nodes(ss_publisher *publisher, int32_t first, int32_t count)
{
    const ss_publish_mesh *mesh = &publisher->mesh;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t node = first + i;
        publisher->chunk_file_node[i] = mesh->file_node != NULL ? mesh->file_node[node] : node;
        publisher->chunk_flag[i] = mesh->fixed != NULL && mesh->fixed[node] != 0 ? 1 : 0;
        for (int d = 0; d < 3; ++d) {
            publisher->chunk_rest[i][d] = (float)mesh->rest[node][d];
        }
    }
}

/* The next chunk: nodes while there are any, then triangles in the room that is left. */
static send_result send_topology(ss_publisher *publisher, int64_t now_ns)
{
    if (!publisher->is_round_open) {
        return NOTHING_DUE;
    }
    const ss_publish_mesh *mesh = &publisher->mesh;
    const int32_t room = publisher->message_limit - TOPOLOGY_HEADER;
    const int32_t nodes_left = mesh->node_count - publisher->next_node;
    const int32_t nodes = nodes_left < room / NODE_BYTES ? nodes_left : room / NODE_BYTES;
    const int32_t triangle_room = (room - nodes * NODE_BYTES) / TRIANGLE_BYTES;
    const int32_t triangles_left = mesh->triangle_count - publisher->next_triangle;
    const int32_t triangles = triangles_left < triangle_room ? triangles_left : triangle_room;
    const int32_t size = TOPOLOGY_HEADER + nodes * NODE_BYTES + triangles * TRIANGLE_BYTES;
    if (publisher->tokens < size) {
        return OUT_OF_TOKENS;
    }
    fill_nodes(publisher, publisher->next_node, nodes);
    const softsim_mesh_topology_t wire = {.utime = now_ns / 1000,
                                          .seq = ++publisher->topology_seq,
                                          .topology = publisher->topology,
                                          .node_count = mesh->node_count,
                                          .triangle_count = mesh->triangle_count,
                                          .first_node = publisher->next_node,
                                          .node_chunk = nodes,
                                          .rest_count = 3 * nodes,
                                          .first_triangle = publisher->next_triangle,
                                          .triangle_index_count = 3 * triangles,
                                          .scale = publisher->scale,
                                          .file_node = publisher->chunk_file_node,
                                          .node_flag = publisher->chunk_flag,
                                          .rest = &publisher->chunk_rest[0][0],
                                          .triangle = (int32_t *)mesh->triangle +
                                                      3 * (int64_t)publisher->next_triangle};
    publish(publisher, publisher->topology_channel,
            softsim_mesh_topology_t_encode(publisher->buffer, 0, sizeof publisher->buffer, &wire));
    publisher->next_node += nodes;
    publisher->next_triangle += triangles;
    publisher->is_round_open =
        publisher->next_node < mesh->node_count || publisher->next_triangle < mesh->triangle_count;
    return SENT;
}

static void open_round_when_due(ss_publisher *publisher, int64_t now_ns)
{
    const bool rests = is_resting(publisher, now_ns);
    const int64_t period_ns = rests ? REST_PERIOD_NS : TOPOLOGY_PERIOD_NS;
    const bool is_due =
        !publisher->is_round_open && now_ns - publisher->round_start_ns >= period_ns;
    if (is_due || publisher->is_round_wanted) {
        if (rests) {
            publisher->sweep_due = publisher->mesh.node_count;
            publisher->wants_field = true;
        }
        publisher->is_round_open = true;
        publisher->is_round_wanted = false;
        publisher->round_start_ns = now_ns;
        publisher->next_node = 0;
        publisher->next_triangle = 0;
    }
}

/* ---- deltas ---- */

/* Takes over a new state; a node that is not finite keeps its last place. */
static void quantize(ss_publisher *publisher, const float *displacement)
{
    const double counts_per_m = 1.0 / (double)publisher->scale;
    bool is_clamping = false;
    for (int32_t i = 0; i < publisher->mesh.node_count; ++i) {
        const float *u = displacement + 3 * (int64_t)i;
        if (!isfinite(u[0]) || !isfinite(u[1]) || !isfinite(u[2])) {
            continue;
        }
        for (int d = 0; d < 3; ++d) {
            const double counts = rint((double)u[d] * counts_per_m);
            const double clamped = fmin(fmax(counts, -MAX_COUNT), MAX_COUNT);
            is_clamping |= clamped != counts;
            publisher->is_changed |= publisher->latest[i][d] != (int16_t)clamped;
            publisher->latest[i][d] = (int16_t)clamped;
        }
    }
    atomic_store_explicit(&publisher->is_clamping, is_clamping, memory_order_relaxed);
}

static bool is_same(const int16_t a[3], const int16_t b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static void add_node(ss_publisher *publisher, int32_t node)
{
    static const int16_t rest[3] = {0, 0, 0};
    const int16_t *latest = publisher->latest[node];
    publisher->node[publisher->moved_count] = node;
    memcpy(publisher->displacement[publisher->moved_count], latest, sizeof(int16_t[3]));
    memcpy(publisher->sent[node], latest, sizeof(int16_t[3]));
    publisher->is_swept[node] |= is_same(latest, rest) ? 0 : 1;
    publisher->in_message[node] = (uint32_t)publisher->delta_seq;
    publisher->moved_count += 1;
}

/* Goes on with the sweep until it is on time or the message holds `limit` nodes. */
static void add_swept(ss_publisher *publisher, int32_t limit)
{
    while (publisher->sweep_due >= 1.0 && publisher->moved_count < limit) {
        const int32_t node = publisher->sweep_cursor;
        publisher->sweep_cursor = (node + 1) % publisher->mesh.node_count;
        publisher->sweep_due -= 1.0;
        if (publisher->is_swept[node] != 0 &&
            publisher->in_message[node] != (uint32_t)publisher->delta_seq) {
            add_node(publisher, node);
        }
    }
}

/* The next message begins where this one had to end, so that every changed node has its turn. */
static void add_changed(ss_publisher *publisher, int32_t limit)
{
    const int32_t count = publisher->mesh.node_count;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t node = publisher->changed_cursor;
        if (!is_same(publisher->latest[node], publisher->sent[node])) {
            if (publisher->moved_count == limit) {
                return;
            }
            add_node(publisher, node);
        }
        publisher->changed_cursor = (node + 1) % count;
    }
}

static send_result send_delta(ss_publisher *publisher, int64_t now_ns)
{
    /* Few large messages rather than many small ones when tokens are short. */
    if (publisher->tokens < publisher->message_limit / 4.0) {
        return OUT_OF_TOKENS;
    }
    const int32_t bytes = (int32_t)fmin(publisher->message_limit, publisher->tokens);
    const int32_t limit = (bytes - DELTA_HEADER) / MOVED_BYTES;
    if (limit < 1) {
        return OUT_OF_TOKENS;
    }
    publisher->delta_seq += 1;
    publisher->moved_count = 0;
    add_swept(publisher, (limit + 1) / 2);
    add_changed(publisher, limit);
    add_swept(publisher, limit);
    if (publisher->moved_count == 0) {
        publisher->delta_seq -= 1;
        return NOTHING_DUE;
    }
    const softsim_mesh_delta_t wire = {.utime = now_ns / 1000,
                                       .step = publisher->step,
                                       .seq = publisher->delta_seq,
                                       .topology = publisher->topology,
                                       .count = publisher->moved_count,
                                       .displacement_count = 3 * publisher->moved_count,
                                       .node = publisher->node,
                                       .displacement = &publisher->displacement[0][0]};
    publish(publisher, publisher->delta_channel,
            softsim_mesh_delta_t_encode(publisher->buffer, 0, sizeof publisher->buffer, &wire));
    return SENT;
}

/* ---- fields ---- */

void ss_publisher_set_field(ss_publisher *publisher, int64_t now_ns, int64_t step, const char *name,
                            const char *unit, const float *value)
{
    const int32_t count = publisher->mesh.node_count;
    float largest = 0.0F;
    if (publisher->field == NULL) {
        publisher->field = ss_memory_get((size_t)count, sizeof *publisher->field);
        publisher->field_cursor = count;
    }
    if (publisher->field == NULL) {
        return; /* the body is shown without */
    }
    if (strcmp(name, publisher->field_name) != 0) {
        snprintf(publisher->field_name, sizeof publisher->field_name, "%s", name);
        snprintf(publisher->field_unit, sizeof publisher->field_unit, "%s", unit);
        publisher->field_reach = 0.0F;
        publisher->field_ns = -FIELD_PERIOD_NS;
        publisher->is_field_signed = false;
    }
    for (int32_t i = 0; i < count; ++i) {
        const float size = fabsf(value[i]);
        largest = isfinite(size) && size > largest ? size : largest;
        publisher->is_field_signed |= value[i] < 0.0F;
    }
    const float reach = fmaxf(fmaxf(largest, FIELD_FADE * publisher->field_reach), 1e-12F);
    bool is_changed = reach != publisher->field_reach || publisher->wants_field;
    publisher->wants_field = false;
    publisher->field_reach = reach;
    for (int32_t i = 0; i < count; ++i) {
        const float share = isfinite(value[i]) ? value[i] / reach : 0.0F;
        const int16_t counts =
            (int16_t)lrintf(MAX_COUNT * (publisher->is_field_signed ? share : 2.0F * share - 1.0F));
        is_changed |= publisher->field[i] != counts;
        publisher->field[i] = counts;
    }
    const int64_t period_ns = is_resting(publisher, now_ns) ? REST_PERIOD_NS : FIELD_PERIOD_NS;
    if (is_changed || now_ns - publisher->field_ns >= period_ns) {
        publisher->field_cursor = 0;
        publisher->field_step = step;
        publisher->field_ns = now_ns;
    }
}

/* False: nothing was due, or nothing could be sent. */
static bool send_field(ss_publisher *publisher, int64_t now_ns)
{
    const int32_t left = publisher->mesh.node_count - publisher->field_cursor;
    const int32_t room = (publisher->message_limit - FIELD_HEADER) / (int32_t)sizeof(int16_t);
    const int32_t count = left < room ? left : room;
    if (publisher->field == NULL || count < 1 ||
        publisher->tokens < FIELD_HEADER + count * (int32_t)sizeof(int16_t)) {
        return false;
    }
    const softsim_mesh_field_t wire = {.utime = now_ns / 1000,
                                       .step = publisher->field_step,
                                       .seq = ++publisher->field_seq,
                                       .topology = publisher->topology,
                                       .first_node = publisher->field_cursor,
                                       .count = count,
                                       .name = publisher->field_name,
                                       .unit = publisher->field_unit,
                                       .low = publisher->is_field_signed ? -publisher->field_reach
                                                                         : 0.0F,
                                       .high = publisher->field_reach,
                                       .value = publisher->field + publisher->field_cursor};
    publish(publisher, publisher->field_channel,
            softsim_mesh_field_t_encode(publisher->buffer, 0, sizeof publisher->buffer, &wire));
    publisher->field_cursor += count;
    return true;
}

/* ---- opening ---- */

/* Positive, and the same for the same mesh. */
static int32_t topology_number(const ss_publish_mesh *mesh)
{
    uint64_t hash = SS_HASH_START;
    hash = ss_hash_bytes(hash, mesh->rest, (size_t)mesh->node_count * sizeof mesh->rest[0]);
    hash = ss_hash_bytes(hash, mesh->triangle,
                         (size_t)mesh->triangle_count * sizeof mesh->triangle[0]);
    const int32_t number = (int32_t)((hash ^ hash >> 32) & INT32_MAX);
    return number > 0 ? number : 1;
}

void ss_publisher_close(ss_publisher **publisher)
{
    if (*publisher == NULL) {
        return;
    }
    if ((*publisher)->lcm != NULL) {
        lcm_destroy((*publisher)->lcm);
    }
    SS_EACH(ss_memory_free, (*publisher)->field, (*publisher)->latest, (*publisher)->sent,
            (*publisher)->is_swept, (*publisher)->in_message, *publisher);
    *publisher = NULL;
}

lcm_t *ss_publisher_lcm(ss_publisher *publisher)
{
    return publisher->lcm;
}

softsim_status ss_publisher_open(const ss_publisher_config *config, const ss_publish_mesh *mesh,
                                 ss_publisher **out_publisher, softsim_error *error)
{
    softsim_status status = SOFTSIM_ERROR_ARGUMENT;
    ss_publisher *publisher = NULL;
    *out_publisher = NULL;
    const float scale = (float)(mesh->diagonal / COUNTS_PER_DIAGONAL);
    if (!ss_wire_check_prefix(config->prefix, error)) {
        return status;
    }
    if (mesh->node_count < 1 || mesh->triangle_count < 0 || !isnormal(scale) || scale < 0.0f) {
        softsim_error_add(error, status, "the surface to publish is empty or has no size");
        return status;
    }
    status = SOFTSIM_ERROR_MEMORY;
    publisher = ss_memory_get(1, sizeof *publisher);
    if (publisher == NULL) {
        goto fail;
    }
    const size_t nodes = (size_t)mesh->node_count;
    publisher->latest = ss_memory_get(nodes, sizeof publisher->latest[0]);
    publisher->sent = ss_memory_get(nodes, sizeof publisher->sent[0]);
    publisher->is_swept = ss_memory_get(nodes, sizeof publisher->is_swept[0]);
    publisher->in_message = ss_memory_get(nodes, sizeof publisher->in_message[0]);
    if (publisher->latest == NULL || publisher->sent == NULL || publisher->is_swept == NULL ||
        publisher->in_message == NULL) {
        goto fail;
    }
    publisher->mesh = *mesh;
    publisher->scale = scale;
    publisher->topology = topology_number(mesh);
    publisher->tokens = (double)INFINITY; /* the bucket starts full */
    ss_publisher_set_max_bytes(publisher, config->max_bytes_per_s);
    snprintf(publisher->topology_channel, SS_WIRE_CHANNEL_SIZE, "%s_MESH_TOPOLOGY", config->prefix);
    snprintf(publisher->field_channel, SS_WIRE_CHANNEL_SIZE, "%s_MESH_FIELD", config->prefix);
    snprintf(publisher->delta_channel, SS_WIRE_CHANNEL_SIZE, "%s_MESH_DELTA", config->prefix);
    /* Computed here, not in the loop: the generated code does it on first use. */
    __softsim_mesh_topology_t_get_hash();
    __softsim_mesh_delta_t_get_hash();
    __softsim_mesh_field_t_get_hash();
    publisher->lcm = ss_wire_open(config->lcm_url, error);
    if (publisher->lcm == NULL) {
        status =
            error != NULL && error->status != SOFTSIM_OK ? error->status : SOFTSIM_ERROR_NETWORK;
        goto fail;
    }
    *out_publisher = publisher;
    return SOFTSIM_OK;
fail:
    ss_publisher_close(&publisher);
    return status;
}

/* ---- sending ---- */

int32_t ss_publisher_topology(const ss_publisher *publisher)
{
    return publisher->topology;
}

int64_t ss_publisher_bytes(const ss_publisher *publisher)
{
    return atomic_load_explicit(&publisher->bytes, memory_order_relaxed);
}

bool ss_publisher_is_clamping(const ss_publisher *publisher)
{
    return atomic_load_explicit(&publisher->is_clamping, memory_order_relaxed);
}

bool ss_publisher_is_capped(const ss_publisher *publisher)
{
    return atomic_load_explicit(&publisher->is_capped, memory_order_relaxed);
}

void ss_publisher_refresh(ss_publisher *publisher)
{
    publisher->is_round_wanted = true;
    publisher->sweep_due = publisher->mesh.node_count;
    publisher->wants_field = true;
}

bool ss_publisher_wants_field(const ss_publisher *publisher)
{
    return publisher->wants_field;
}

/* Lets time pass for the bucket, the sweep and the topology. */
static void advance(ss_publisher *publisher, int64_t now_ns)
{
    if (!publisher->has_started) {
        publisher->has_started = true;
        publisher->is_round_wanted = true;
        publisher->is_topology_turn = true;
        publisher->last_ns = now_ns;
        publisher->sweep_kept_ns = now_ns;
        publisher->changed_ns = now_ns;
    }
    publisher->changed_ns = publisher->is_changed ? now_ns : publisher->changed_ns;
    publisher->is_changed = false;
    const double passed_s =
        now_ns > publisher->last_ns ? (double)(now_ns - publisher->last_ns) * 1e-9 : 0.0;
    const double nodes = publisher->mesh.node_count;
    publisher->last_ns = now_ns;
    publisher->tokens =
        fmin(publisher->tokens + publisher->fill_per_s * passed_s, publisher->depth);
    if (!is_resting(publisher, now_ns)) {
        publisher->sweep_due = fmin(publisher->sweep_due + nodes * passed_s / SWEEP_S, nodes);
    }
    open_round_when_due(publisher, now_ns);
}

/* Late for longer than the slack: the sweep by a quarter of its way (0.2 s) or the topology. */
static void judge_lateness(ss_publisher *publisher, int64_t now_ns)
{
    const double nodes = publisher->mesh.node_count;
    if (publisher->sweep_due <= fmax(1.0, nodes * LATE_S / SWEEP_S) ||
        is_resting(publisher, now_ns)) {
        publisher->sweep_kept_ns = now_ns;
    }
    const bool is_sweep_late = (double)(now_ns - publisher->sweep_kept_ns) * 1e-9 > LATE_S;
    const bool is_topology_late =
        publisher->is_round_open && now_ns - publisher->round_start_ns >= TOPOLOGY_PERIOD_NS;
    atomic_store_explicit(&publisher->is_capped, is_sweep_late || is_topology_late,
                          memory_order_relaxed);
}

/* One message, of the kind whose turn it is if that is due. False: nothing can be sent now. */
static bool send_one(ss_publisher *publisher, int64_t now_ns)
{
    for (int attempt = 0; attempt < 2; ++attempt) {
        const send_result result = publisher->is_topology_turn ? send_topology(publisher, now_ns)
                                                               : send_delta(publisher, now_ns);
        if (result == OUT_OF_TOKENS) {
            return false; /* and keeps its turn */
        }
        publisher->is_topology_turn = !publisher->is_topology_turn;
        if (result == SENT) {
            return true;
        }
    }
    return false;
}

void ss_publisher_send(ss_publisher *publisher, int64_t now_ns, int64_t step,
                       const float *displacement)
{
    if (displacement != NULL) {
        publisher->step = step;
        quantize(publisher, displacement);
    }
    advance(publisher, now_ns);
    /* A field comes first in every other call, else where the mesh leaves room. */
    publisher->is_field_turn = !publisher->is_field_turn;
    int room = MESSAGES_PER_CALL;
    if (publisher->is_field_turn && send_field(publisher, now_ns)) {
        --room;
    }
    while (room > 0 && send_one(publisher, now_ns)) {
        --room;
    }
    if (room > 0) {
        send_field(publisher, now_ns);
    }
    judge_lateness(publisher, now_ns);
}
