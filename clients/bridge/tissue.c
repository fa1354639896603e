/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "tissue.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "body.h"
#include "process.h"

/* A server publishes both every 2 s and on demand; a large body a piece at a time, for seconds. */
static const int64_t patience_ns = 3000000000, ask_again_ns = 500000000;
static const int64_t longest_ns = 60000000000; /* though pieces come */

typedef struct heard {
    ss_body_view body;
    int32_t probe;
    bool has_status, has_scene, is_too_large;
    int64_t last_ns;  /* that a piece came */
    int32_t topology; /* of the scene; 0: it publishes no mesh */
    softsim_tool_form form;
    ss_touch_end end;
} heard;

static void take_status(void *context, const softsim_server_status *status, int64_t receive_ns)
{
    (void)status;
    heard *h = context;
    h->last_ns = h->has_status ? h->last_ns : receive_ns;
    h->has_status = true;
}

static void take_topology(void *context, const softsim_topology_chunk *chunk)
{
    heard *h = context;
    const int32_t missing = h->body.nodes_missing + h->body.triangles_missing;
    h->is_too_large = !ss_body_take_topology(&h->body, chunk);
    if (h->body.nodes_missing + h->body.triangles_missing != missing) {
        h->last_ns = softsim_client_now_ns();
    }
}

/* The cylinder around a convex tool's vertices, as far as it lies towards -z. */
static ss_touch_end end_of_hull(const softsim_scene_report *scene, int32_t probe)
{
    ss_touch_end end = {0};
    const float *vertex = scene->hull;
    for (int32_t p = 0; p < probe; ++p) {
        vertex += 3 * (ptrdiff_t)scene->hull_count[p];
    }
    for (int32_t i = 0; i < scene->hull_count[probe]; ++i, vertex += 3) {
        end.radius = fmax(end.radius, hypot((double)vertex[0], (double)vertex[1]));
        end.below = fmax(end.below, -(double)vertex[2]);
    }
    return end;
}

static void take_scene(void *context, const softsim_scene_report *scene)
{
    heard *h = context;
    const double *size = scene->size[h->probe];
    ss_shape shape = {.radius = size[0], .half_length = 0.5 * size[1]};
    h->has_scene = true;
    h->topology = scene->topology;
    h->form = scene->form[h->probe];
    switch (h->form) {
    case SOFTSIM_TOOL_NONE:
        return;
    case SOFTSIM_TOOL_CONVEX:
        h->end = end_of_hull(scene, h->probe);
        return;
    case SOFTSIM_TOOL_SPHERE:
        shape.kind = SS_SHAPE_SPHERE;
        break;
    case SOFTSIM_TOOL_CAPSULE:
        shape.kind = SS_SHAPE_CAPSULE;
        break;
    case SOFTSIM_TOOL_CYLINDER:
        shape.kind = SS_SHAPE_CYLINDER;
        break;
    case SOFTSIM_TOOL_CONE:
        shape.kind = SS_SHAPE_CONE;
        break;
    case SOFTSIM_TOOL_BOX:
        shape.kind = SS_SHAPE_BOX;
        for (int k = 0; k < 3; ++k) {
            shape.half_extent[k] = 0.5 * size[k];
        }
        break;
    }
    h->end = ss_touch_end_of(&shape);
}

/* Is there anything more to wait for? */
static bool is_enough(const heard *h)
{
    return h->has_scene && (h->topology == 0 || h->form == SOFTSIM_TOOL_NONE || h->is_too_large ||
                            (h->body.is_complete && h->body.topology == h->topology));
}

static bool listen(const softsim_client_config *config, double start_s, heard *h,
                   softsim_error *error)
{
    const softsim_client_config listening = {.lcm_url = config->lcm_url,
                                             .prefix = config->prefix,
                                             .context = h,
                                             .handle_status = take_status,
                                             .handle_scene = take_scene,
                                             .handle_topology = take_topology};
    softsim_client *client = NULL;
    if (softsim_client_open(&listening, &client, error) != SOFTSIM_OK) {
        return false;
    }
    int64_t now_ns = softsim_client_now_ns(), ask_ns = now_ns;
    const int64_t end_ns = now_ns + longest_ns, start_ns = (int64_t)(1e9 * start_s);
    h->last_ns = now_ns;
    bool is_good = true;
    while (is_good && !is_enough(h) && !ss_process_is_stopped() && now_ns < end_ns &&
           now_ns - h->last_ns < (h->has_status || h->has_scene ? patience_ns : start_ns)) {
        if (now_ns >= ask_ns) {
            softsim_client_send_command(client, "refresh", "");
            ask_ns = now_ns + ask_again_ns;
        }
        is_good = softsim_client_wait(client, ask_ns) >= 0;
        now_ns = softsim_client_now_ns();
    }
    softsim_client_close(&client);
    return true;
}

/* The surface in double, as contact takes it. */
static bool copy_body(const ss_body_view *from, ss_tissue *to)
{
    const size_t nodes = (size_t)from->node_count, triangles = (size_t)from->triangle_count + 1;
    double(*position)[3] = calloc(nodes, sizeof *position);
    int32_t(*triangle)[3] = calloc(triangles, sizeof *triangle);
    uint8_t *fixed = calloc(nodes, 1);
    to->body = (ss_touch_body){from->node_count, from->triangle_count, (const double(*)[3])position,
                               (const int32_t(*)[3])triangle, fixed};
    if (position == NULL || triangle == NULL || fixed == NULL) {
        ss_tissue_free(to);
        return false;
    }
    for (size_t i = 0; i < nodes; ++i) {
        for (int k = 0; k < 3; ++k) {
            position[i][k] = (double)from->rest[i][k];
        }
        fixed[i] = from->flag[i] & 1;
    }
    memcpy(triangle, from->triangle, (triangles - 1) * sizeof *triangle);
    return true;
}

bool ss_tissue_hear(const softsim_client_config *config, int32_t probe, double start_s,
                    ss_tissue *out, softsim_error *error)
{
    static const char *const names[] = {
#define X(name, value, text) [value] = (text),
        SOFTSIM_TOOL_LIST(X)
#undef X
    };
    heard h = {.probe = probe, .body.newest = -1};
    *out = (ss_tissue){0};
    char unheard[128];
    if (!listen(config, start_s, &h, error)) {
        return false;
    }
    const char *why = NULL;
    if (!h.has_scene && !h.has_status) {
        snprintf(unheard, sizeof unheard,
                 "no server was heard in %g s; is softsimd running, with this prefix and LCM url?",
                 start_s);
        why = ss_process_is_stopped() ? "stopped before a server was heard" : unheard;
    } else if (!h.has_scene) {
        why = "the server has not told its scene; try again, or give --offset-m X,Y,Z";
    } else if (h.form == SOFTSIM_TOOL_NONE) {
        why = "its scene has no tool for this probe; give --probe N, or add one to contact.tools";
    } else if (h.topology == 0) {
        why = "its scene publishes no mesh (publish.mesh_rate_hz: 0); give --offset-m X,Y,Z";
    } else if (!h.body.is_complete || h.body.topology != h.topology) {
        why = "the server's mesh did not come whole; try again, or give --offset-m X,Y,Z";
    } else if (!copy_body(&h.body, out)) {
        why = "out of memory";
    }
    ss_body_free(&h.body);
    out->end = h.end;
    out->tool = names[h.form];
    if (why != NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "the tissue was not found: %s", why);
    }
    return why == NULL;
}

void ss_tissue_free(ss_tissue *tissue)
{
    free((void *)(uintptr_t)tissue->body.position);
    free((void *)(uintptr_t)tissue->body.triangle);
    free((void *)(uintptr_t)tissue->body.fixed);
    *tissue = (ss_tissue){0};
}
