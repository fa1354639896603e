/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The preview: the body at rest from the front and from the side, the hand's side up. Projection,
 * light and the order of faces from far to near are computed here, so that gnuplot only fills
 * polygons (as tools/bench/core/surface_picture.c does for the reports, into their pages). gnuplot
 * gets its script on stdin and gives the picture on stdout, so that no path goes through it.
 */
#include "organ.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "leftover.h"
#include "output.h"
#include "rt/order.h"
#include "rt/vec.h"

extern char **environ;

enum { VIEWS = 2, WIDTH = 900, ARC = 48 };
static const uint32_t free_colour = 0xd8a58a, fixed_colour = 0x4a6a8a;

typedef struct canvas {
    double right[3], up[3], eye[3];
    double low[2], high[2];
    double shift;
} canvas;

/* The hand's side up, seen from across it: `turn` 0 the front, 1 a quarter round. */
static void set_axes(const organ *o, int turn, canvas *c)
{
    const double *a = o->towards;
    const int k = fabs(a[0]) > 0.5 ? 1 : 0; /* an axis across */
    double across[3] = {0.0, 0.0, 0.0}, other[3];
    across[k] = 1.0;
    ss_cross3(other, a, across);
    if (turn == 0) {
        ss_scale3(across, other, -1.0);
    }
    ss_scale3(c->eye, across, 1.0);
    ss_madd3(c->eye, c->eye, 0.35, a);
    ss_normalize3(c->eye);
    ss_cross3(c->right, a, c->eye);
    ss_normalize3(c->right);
    ss_cross3(c->up, c->eye, c->right);
}

static void flatten(const canvas *c, const double x[3], double out[2])
{
    out[0] = ss_dot3(x, c->right) + c->shift;
    out[1] = ss_dot3(x, c->up);
}

static void widen(canvas *c, const double x[3], double margin)
{
    double p[2];
    flatten(c, x, p);
    for (int k = 0; k < 2; ++k) {
        c->low[k] = fmin(c->low[k], p[k] - margin);
        c->high[k] = fmax(c->high[k], p[k] + margin);
    }
}

static void put_face(FILE *file, const ss_touch_body *body, const canvas *c, int32_t t)
{
    const int32_t *n = body->triangle[t];
    const bool is_fixed =
        body->fixed[n[0]] != 0 && body->fixed[n[1]] != 0 && body->fixed[n[2]] != 0;
    const uint32_t colour = is_fixed ? fixed_colour : free_colour;
    double normal[3], p[2];
    ss_normal3(normal, body->position[n[0]], body->position[n[1]], body->position[n[2]]);
    ss_normalize3(normal);
    const double light =
        0.45 + 0.55 * fmax(0.0, 0.8 * ss_dot3(normal, c->eye) + 0.35 * ss_dot3(normal, c->up));
    uint32_t shaded = 0;
    for (int k = 16; k >= 0; k -= 8) {
        shaded |= (uint32_t)fmin(255.0, light * (double)(colour >> k & 255u)) << k;
    }
    (void)fprintf(file, "set object polygon from ");
    for (int k = 0; k < 4; ++k) {
        flatten(c, body->position[n[k % 3]], p);
        (void)fprintf(file, "%s%.5g,%.5g", k > 0 ? " to " : "", p[0], p[1]);
    }
    (void)fprintf(file, " fc rgb '#%06x' fs solid border lc rgb '#%06x' lw 0.3\n", shaded,
                  shaded - (shaded >> 3 & 0x1f1f1fu));
}

static void put_held_node(FILE *file, const ss_touch_body *body, const canvas *c, int32_t i,
                          double size)
{
    double p[2];
    flatten(c, body->position[i], p);
    (void)fprintf(file,
                  "set object circle at %.5g,%.5g size %.5g fs solid noborder fc rgb '#%06x'\n",
                  p[0], p[1], size, fixed_colour);
}

/* Faces that look this way, and held nodes of the surface, from far to near: the body hides what is
 * behind it. `order` has room for both; a node i is -1 - i there. */
static void put_body(FILE *file, const ss_touch_body *body, const canvas *c, ss_keyed *order,
                     double size)
{
    int32_t count = 0;
    for (int32_t t = 0; t < body->triangle_count; ++t) {
        double normal[3], depth = 0.0;
        const int32_t *n = body->triangle[t];
        ss_normal3(normal, body->position[n[0]], body->position[n[1]], body->position[n[2]]);
        for (int k = 0; k < 3; ++k) {
            const double own = ss_dot3(body->position[n[k]], c->eye);
            depth += own / 3.0;
            if (body->fixed[n[k]] != 0) {
                order[count++] = (ss_keyed){own, -1 - n[k]};
            }
        }
        if (ss_dot3(normal, c->eye) > 0.0) {
            order[count++] = (ss_keyed){depth, t};
        }
    }
    qsort(order, (size_t)count, sizeof *order, ss_compare_keyed);
    for (int32_t i = 0; i < count; ++i) {
        const bool is_again = i > 0 && order[i].index == order[i - 1].index;
        if (order[i].index >= 0) {
            put_face(file, body, c, order[i].index);
        } else if (!is_again) {
            put_held_node(file, body, c, -1 - order[i].index, size);
        }
    }
}

static void put_tool(FILE *file, const organ *o, const canvas *c)
{
    double from[2], to[2], above[3];
    ss_madd3(above, o->touch.origin, 4.0 * o->radius, o->towards);
    flatten(c, above, from);
    ss_madd3(above, o->touch.origin, 1.2 * o->radius, o->towards);
    flatten(c, above, to);
    (void)fprintf(file, "set arrow from %.5g,%.5g to %.5g,%.5g front lw 2.5 lc rgb '#b00020'\n",
                  from[0], from[1], to[0], to[1]);
    flatten(c, o->touch.origin, to);
    (void)fprintf(
        file,
        "set object circle at %.5g,%.5g size %.5g front fs transparent solid 0.75 border lc rgb "
        "'#700014' fc rgb '#d04050'\n",
        to[0], to[1], o->radius);
}

static void put_script(FILE *file, const organ *o, const ss_touch_body *body, ss_keyed *order)
{
    canvas c[VIEWS];
    double width = 0.0, low = INFINITY, high = -INFINITY;
    for (int v = 0; v < VIEWS; ++v) {
        c[v] = (canvas){.low = {INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY}};
        set_axes(o, v, &c[v]);
        for (int32_t t = 0; t < 3 * body->triangle_count; ++t) {
            widen(&c[v], body->position[body->triangle[t / 3][t % 3]], 0.0);
        }
        double top[3];
        ss_madd3(top, o->touch.origin, 4.0 * o->radius, o->towards);
        widen(&c[v], top, 0.0);
        widen(&c[v], o->touch.origin, o->radius);
        const double gap = 0.06 * (c[v].high[0] - c[v].low[0]);
        c[v].shift = width + gap - c[v].low[0];
        width += c[v].high[0] - c[v].low[0] + 2.0 * gap;
        low = fmin(low, c[v].low[1]);
        high = fmax(high, c[v].high[1]);
    }
    const double margin = 0.12 * (high - low), height = high - low + 2.0 * margin;
    (void)fprintf(
        file,
        "set terminal pngcairo size %d,%d font 'sans,10'\nunset key\nunset tics\nunset border\n"
        "set margins 0,0,0,0\nset size ratio -1\nset xrange [0:%.6g]\nset yrange [%.6g:%.6g]\n",
        WIDTH, (int)fmin(2.0 * WIDTH, fmax(200.0, WIDTH * height / width)), width, low - margin,
        high + margin);
    for (int v = 0; v < VIEWS; ++v) {
        put_body(file, body, &c[v], order, 0.003 * width);
        put_tool(file, o, &c[v]);
    }
    (void)fprintf(
        file,
        "set label '%s, %s: %.3g x %.3g x %.3g mm; blue: held (%d of %d nodes); ball of %.3g "
        "mm from %s' at %.6g,%.6g center front\nplot NaN\n",
        o->tissue->name, o->model->name, 1e3 * (o->high[0] - o->low[0]),
        1e3 * (o->high[1] - o->low[1]), 1e3 * (o->high[2] - o->low[2]), o->fixed_count,
        o->node_count, 1e3 * o->radius, o->side, 0.5 * width, low - 0.6 * margin);
}

/* Runs gnuplot from `script` to the picture's file. */
static softsim_status run_gnuplot(FILE *script, const ss_output *picture, softsim_error *error)
{
    char name[] = "gnuplot", *const argv[] = {name, NULL};
    posix_spawn_file_actions_t actions;
    pid_t pid;
    int status = 0;
    if (posix_spawn_file_actions_init(&actions) != 0) {
        return SOFTSIM_ERROR_MEMORY;
    }
    (void)posix_spawn_file_actions_adddup2(&actions, fileno(script), 0);
    (void)posix_spawn_file_actions_adddup2(&actions, picture->descriptor, 1);
    const int failure = posix_spawnp(&pid, name, &actions, NULL, argv, environ);
    (void)posix_spawn_file_actions_destroy(&actions);
    if (failure != 0) {
        softsim_error_add(
            error, SOFTSIM_ERROR_SYSTEM,
            "--preview: gnuplot cannot be started (%s): install it (Debian: gnuplot-nox)",
            strerror(failure));
        return SOFTSIM_ERROR_SYSTEM;
    }
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SYSTEM, "--preview: gnuplot failed (status %d)",
                          WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
        return SOFTSIM_ERROR_SYSTEM;
    }
    return SOFTSIM_OK;
}

/* A PNG ends with a chunk of this name and its sum: gnuplot tells of no full disk. */
static bool is_whole(const ss_output *picture)
{
    static const char end[] = "IEND\xae"
                              "B`\x82";
    char found[sizeof end - 1] = "";
    FILE *file = picture->temporary != NULL ? fopen(picture->temporary, "rb") : NULL;
    const bool is_read = file != NULL && fseek(file, -(long)sizeof found, SEEK_END) == 0 &&
                         fread(found, sizeof found, 1, file) == 1;
    if (file != NULL) {
        (void)fclose(file);
    }
    return picture->temporary == NULL || (is_read && memcmp(found, end, sizeof found) == 0);
}

softsim_status organ_draw(const organ *o, const ss_touch_body *body, const char *path,
                          softsim_error *error)
{
    ss_output picture = {0};
    FILE *script = tmpfile();
    ss_keyed *order = calloc(4 * (size_t)body->triangle_count + 1, sizeof *order);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (script != NULL && order != NULL) {
        status = leftover_open(&picture, path, error);
    }
    if (status == SOFTSIM_OK) {
        put_script(script, o, body, order);
        const bool is_written = fflush(script) == 0 && fseek(script, 0, SEEK_SET) == 0;
        status = is_written ? run_gnuplot(script, &picture, error) : SOFTSIM_ERROR_FILE;
    }
    if (status == SOFTSIM_OK && !is_whole(&picture)) {
        status = SOFTSIM_ERROR_FILE;
        softsim_error_add(error, status, "%s: cannot be written whole: is the disk full?", path);
    } else if (status == SOFTSIM_OK) {
        status = leftover_commit(&picture, error);
    } else if (error->fault_count == 0) {
        softsim_error_add(error, status,
                          "--preview: out of memory, or of room for a temporary file");
    }
    leftover_abandon(&picture);
    if (script != NULL) {
        (void)fclose(script);
    }
    free(order);
    return status;
}
