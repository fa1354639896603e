/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What of an organ does not move: what was asked for, or the side away from the hand: .15 of the
 * body's height, and more where that has little of the surface; of separate parts that this has
 * nothing of, their own far side, for they would fly off.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "organ.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { HELD_STEPS = 5, MAX_HELD_PARTS = 16 };
static const double APART = 1e-6;      /* of the diagonal: nodes at one place, or in a line */
static const double HELD_SHARE = 0.15; /* of the body's height, away from the hand */
static const double HELD_MORE = 0.05;  /* of it, a step, while less is held than */
static const double LEAST_HELD = 0.1;  /* of the surface's corners: rounded bodies stand on few */

double organ_height(const organ *o)
{
    double way[3];
    ss_sub3(way, o->high, o->low);
    return fabs(ss_dot3(way, o->towards));
}

/* As an entry of `fixed`: names may hold anything that ends neither a file's line nor its quotes.
 */
static void name_group(const char *name, char *out, size_t size)
{
    char *text = NULL;
    size_t length = 0;
    FILE *stream = open_memstream(&text, &length);
    if (stream != NULL) {
        (void)fprintf(stream, "{group: ");
        organ_write_quoted(stream, name);
        (void)fprintf(stream, "}");
        (void)fclose(stream);
    }
    (void)snprintf(out, size, "%s", text != NULL ? text : "");
    free(text);
}

/* How far a node is from the side away from the hand. */
static double above_far_side(const organ *o, const double x[3])
{
    double up[3];
    ss_sub3(up, x, ss_dot3(o->towards, o->low) < ss_dot3(o->towards, o->high) ? o->low : o->high);
    return ss_dot3(up, o->towards);
}

/* How much of the body's height is held. */
static double held_share(const ss_mesh *mesh, const organ *o)
{
    double share = HELD_SHARE;
    for (int step = 0; step < HELD_STEPS; ++step, share += HELD_MORE) {
        int64_t held = 0;
        for (int32_t i = 0; i < 3 * mesh->triangle_count; ++i) {
            const double *x = mesh->position[mesh->triangle[i / 3][i % 3]];
            held += above_far_side(o, x) <= share * organ_height(o);
        }
        if ((double)held >= 3.0 * LEAST_HELD * mesh->triangle_count) {
            break;
        }
    }
    return share;
}

typedef struct part {
    double low[3], high[3];
    const double *held[2]; /* of those nodes the first, and one that lies apart from it */
    bool is_held;          /* three that are not in a line */
} part;

static void hold_node(part *own, const double x[3], double diagonal)
{
    double along[3], way[3], normal[3];
    own->held[0] = own->held[0] != NULL ? own->held[0] : x;
    ss_sub3(way, x, own->held[0]);
    if (own->held[1] == NULL) {
        own->held[1] = ss_norm3(way) > APART * diagonal ? x : NULL;
        return;
    }
    ss_sub3(along, own->held[1], own->held[0]);
    ss_cross3(normal, along, way);
    own->is_held = own->is_held || ss_norm3(normal) > APART * diagonal * ss_norm3(along);
}

/* Boxes of the bodies, and whether the plane through `point` holds each. */
static void measure_parts(const ss_mesh *mesh, const organ *o, const double point[3],
                          const int32_t *body, part *parts)
{
    for (int32_t i = 0; i < o->part_count; ++i) {
        ss_set3(parts[i].low, INFINITY, INFINITY, INFINITY);
        ss_set3(parts[i].high, -INFINITY, -INFINITY, -INFINITY);
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        const double *x = mesh->position[i];
        part *own = body[i] >= 0 ? &parts[body[i]] : NULL;
        for (int k = 0; k < 3 && own != NULL; ++k) {
            own->low[k] = fmin(own->low[k], x[k]);
            own->high[k] = fmax(own->high[k], x[k]);
        }
        if (own != NULL) {
            double up[3];
            ss_sub3(up, x, point);
            if (ss_dot3(up, o->towards) <= 0.0) {
                hold_node(own, x, o->diagonal);
            }
        }
    }
}

/* Do the nodes of body `number` in a box hold it? */
static bool holds(const ss_mesh *mesh, const organ *o, const int32_t *body, int32_t number,
                  const double low[3], const double high[3])
{
    part own = {.is_held = false};
    for (int32_t i = 0; i < mesh->node_count && !own.is_held; ++i) {
        const double *x = mesh->position[i];
        if (body[i] == number && x[0] >= low[0] && x[1] >= low[1] && x[2] >= low[2] &&
            x[0] <= high[0] && x[1] <= high[1] && x[2] <= high[2]) {
            hold_node(&own, x, o->diagonal);
        }
    }
    return own.is_held;
}

/* Adds a box to what is held, that has the side of a part away from the hand: as much as holds.
 * False where none does. */
static bool hold_part(const ss_mesh *mesh, organ *o, const int32_t *body, int32_t number,
                      const part *own)
{
    const size_t used = strlen(o->fixed);
    double low[3], high[3];
    double share = HELD_SHARE;
    bool is_held;
    do {
        for (int k = 0; k < 3; ++k) {
            const double a = o->towards[k], height = share * (own->high[k] - own->low[k]);
            low[k] = a < 0.0 ? own->high[k] - height : own->low[k];
            high[k] = a > 0.0 ? own->low[k] + height : own->high[k];
        }
        share += HELD_MORE;
        is_held = holds(mesh, o, body, number, low, high);
    } while (share < 1.0 && !is_held);
    if (!is_held) {
        return false;
    }
    (void)snprintf(o->fixed + used, sizeof o->fixed - used,
                   "\n    - {box_m: [[%.5f, %.5f, %.5f], [%.5f, %.5f, %.5f]]}", low[0] - 1e-5,
                   low[1] - 1e-5, low[2] - 1e-5, high[0] + 1e-5, high[1] + 1e-5, high[2] + 1e-5);
    return true;
}

/* Of parts that the plane has nothing of, which would fly off, their own far side is held; of more
 * than can be listed, none. */
static void hold_parts(const ss_mesh *mesh, organ *o, const double point[3])
{
    int32_t *body = ss_memory_get((size_t)mesh->node_count, sizeof *body);
    part *parts = ss_memory_get((size_t)o->part_count + 1, sizeof *parts);
    if (body != NULL && parts != NULL && ss_mesh_find_bodies(mesh, body) == o->part_count) {
        measure_parts(mesh, o, point, body, parts);
        for (int32_t i = 0; i < o->part_count; ++i) {
            o->loose_count += !parts[i].is_held;
        }
        for (int32_t i = 0; i < o->part_count && o->loose_count <= MAX_HELD_PARTS; ++i) {
            if (!parts[i].is_held) {
                o->boxed_count += hold_part(mesh, o, body, i, &parts[i]);
            }
        }
    }
    ss_memory_free(parts);
    ss_memory_free(body);
}

/* What lies behind a plane on the side away from the hand, and the far sides of other parts. */
static void hold_far_side(const ss_mesh *mesh, organ *o)
{
    double point[3];
    const double share = held_share(mesh, o);
    for (int k = 0; k < 3; ++k) {
        const double a = o->towards[k];
        point[k] =
            0.5 * (o->low[k] + o->high[k]) - (0.5 - share) * a * fabs(a) * (o->high[k] - o->low[k]);
        point[k] = 1e-4 * round(1e4 * point[k]); /* as it is written */
    }
    (void)snprintf(o->fixed, sizeof o->fixed,
                   "{plane: {point_m: [%.4f, %.4f, %.4f], normal: [%g, %g, %g]}}", point[0],
                   point[1], point[2], o->towards[0], o->towards[1], o->towards[2]);
    hold_parts(mesh, o, point);
}

softsim_status organ_choose_fixed(const organ_request *q, const ss_mesh *mesh, organ *o,
                                  softsim_error *error)
{
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        if (strcmp(mesh->group[g].name, q->fixed) == 0) {
            name_group(q->fixed, o->fixed, sizeof o->fixed);
            return SOFTSIM_OK;
        }
    }
    if (strcmp(q->fixed, "away") == 0) {
        hold_far_side(mesh, o);
    } else if (strlen(q->fixed) >= sizeof o->fixed) {
        softsim_error_add(
            error, SOFTSIM_ERROR_ARGUMENT,
            "--fixed: longer than %zu characters: give a plane, a box or a group, and "
            "long lists in the scene that is written",
            sizeof o->fixed - 1);
        return SOFTSIM_ERROR_ARGUMENT;
    } else if (q->fixed[0] == '{' && organ_is_text(q->fixed)) {
        (void)snprintf(o->fixed, sizeof o->fixed, "%s", q->fixed);
    } else {
        /* It would be YAML of another meaning. */
        softsim_error_add(
            error, SOFTSIM_ERROR_ARGUMENT,
            "--fixed: '%.60s' is no group of %s; give away, one of its groups "
            "(softsim-mesh info lists them), or an entry such as '{box_m: [[-1, -1, -1], [1, "
            "1, 0]]}'",
            q->fixed, q->mesh);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    return SOFTSIM_OK;
}
