/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/core/surface_picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

static const uint32_t plain_colour = 0xd8a58a;
static const double gap_share = 0.06; /* of a view's width, between two */

typedef struct facet {
    int32_t face;
    double depth, light; /* towards the eye; 0..1 */
} facet;

typedef struct side {
    int32_t from, to;
    bool is_front;
} side;

typedef struct canvas {
    double right[3], up[3], eye[3];
    double low[2], high[2]; /* of what is drawn */
    double shift;           /* to its place beside the others */
} canvas;

static int by_depth(const void *a, const void *b)
{
    const facet *x = a, *y = b;
    return ss_order_double(x->depth, y->depth);
}

static int by_nodes(const void *a, const void *b)
{
    const side *x = a, *y = b;
    return ss_order_then(ss_order_int(x->from, y->from), ss_order_int(x->to, y->to));
}

static int32_t corners(const int32_t face[4])
{
    return face[3] < 0 ? 3 : 4;
}

static void place(const ss_surface_picture *s, int32_t node, bool is_moved, double out[3])
{
    ss_copy3(out, s->rest[node]);
    if (is_moved) {
        ss_add3(out, out, s->u[node]);
    }
}

/* Area vector of a face. */
static void face_normal(const ss_surface_picture *s, int32_t f, bool is_moved, double out[3])
{
    double p[4][3], a[3], b[3];
    const int32_t count = corners(s->face[f]);
    for (int32_t k = 0; k < count; ++k) {
        place(s, s->face[f][k], is_moved, p[k]);
    }
    ss_sub3(a, p[2], p[0]);
    ss_sub3(b, count == 4 ? p[3] : p[2], p[1]);
    ss_cross3(out, a, b);
}

static void set_axes(const ss_surface_picture_view *view, canvas *c)
{
    ss_copy3(c->eye, view->eye);
    ss_normalize3(c->eye);
    ss_cross3(c->right, view->up, c->eye);
    ss_normalize3(c->right);
    ss_cross3(c->up, c->eye, c->right);
}

static void set_bounds(const ss_surface_picture *s, canvas *c)
{
    c->low[0] = c->low[1] = (double)INFINITY;
    c->high[0] = c->high[1] = -(double)INFINITY;
    for (int32_t i = 0; i < 2 * s->node_count; ++i) {
        double p[3];
        place(s, i / 2, i % 2 == 1, p);
        const double at[2] = {ss_dot3(p, c->right), ss_dot3(p, c->up)};
        for (int k = 0; k < 2; ++k) {
            c->low[k] = fmin(c->low[k], at[k]);
            c->high[k] = fmax(c->high[k], at[k]);
        }
    }
}

static void put_point(FILE *file, const canvas *c, const double p[3], const char *after)
{
    fprintf(file, "%.5g,%.5g%s", ss_dot3(p, c->right) + c->shift, ss_dot3(p, c->up), after);
}

/* Light comes over the left shoulder of who looks; a side seen from within is darker. */
static uint32_t shade(uint32_t colour, double light)
{
    uint32_t out = 0;
    for (int k = 16; k >= 0; k -= 8) {
        const double part = (double)(colour >> k & 255u) * light;
        out |= (uint32_t)(part > 255.0 ? 255.0 : part) << k;
    }
    return out;
}

static bool put_faces(FILE *file, const ss_surface_picture *s, const canvas *c)
{
    facet *order = calloc((size_t)s->face_count, sizeof *order);
    double lamp[3];
    if (order == NULL) {
        return false;
    }
    ss_madd3(lamp, c->eye, -0.45, c->right);
    ss_madd3(lamp, lamp, 0.7, c->up);
    ss_normalize3(lamp);
    for (int32_t f = 0; f < s->face_count; ++f) {
        double normal[3], p[3];
        face_normal(s, f, true, normal);
        ss_normalize3(normal);
        const bool is_outside = ss_dot3(normal, c->eye) >= 0.0;
        const double lit = ss_dot3(normal, lamp) * (is_outside ? 1.0 : -1.0);
        order[f] =
            (facet){.face = f, .light = (is_outside ? 1.0 : 0.6) * (0.45 + 0.62 * fmax(lit, 0.0))};
        for (int32_t k = 0; k < corners(s->face[f]); ++k) {
            place(s, s->face[f][k], true, p);
            order[f].depth += ss_dot3(p, c->eye) / corners(s->face[f]);
        }
    }
    qsort(order, (size_t)s->face_count, sizeof *order, by_depth);
    for (int32_t k = 0; k < s->face_count; ++k) {
        const int32_t f = order[k].face;
        const uint32_t colour =
            shade(s->colour != NULL ? s->colour[f] : plain_colour, order[k].light);
        double p[3];
        fputs("set object polygon from ", file);
        for (int32_t n = 0; n <= corners(s->face[f]); ++n) {
            place(s, s->face[f][n % corners(s->face[f])], true, p);
            put_point(file, c, p, n < corners(s->face[f]) ? " to " : " ");
        }
        fprintf(file, "fc rgb '#%06x' fs solid border lc rgb '#%06x' lw 0.4\n", colour,
                shade(colour, 0.72));
    }
    free(order);
    return true;
}

/* Edges of the body at rest with one face, or with one that looks here and one that looks away. */
static bool put_outline(FILE *file, const ss_surface_picture *s, const canvas *c)
{
    side *sides = calloc(4 * (size_t)s->face_count, sizeof *sides);
    int32_t count = 0;
    if (sides == NULL) {
        return false;
    }
    for (int32_t f = 0; f < s->face_count; ++f) {
        double normal[3];
        face_normal(s, f, false, normal);
        for (int32_t k = 0; k < corners(s->face[f]); ++k) {
            const int32_t a = s->face[f][k], b = s->face[f][(k + 1) % corners(s->face[f])];
            sides[count++] = (side){.from = a < b ? a : b,
                                    .to = a < b ? b : a,
                                    .is_front = ss_dot3(normal, c->eye) >= 0.0};
        }
    }
    qsort(sides, (size_t)count, sizeof *sides, by_nodes);
    for (int32_t k = 0; k < count;) {
        const bool is_pair = k + 1 < count && by_nodes(&sides[k], &sides[k + 1]) == 0;
        if (!is_pair || sides[k].is_front != sides[k + 1].is_front) {
            fprintf(file, "%.5g %.5g\n%.5g %.5g\n\n",
                    ss_dot3(s->rest[sides[k].from], c->right) + c->shift,
                    ss_dot3(s->rest[sides[k].from], c->up),
                    ss_dot3(s->rest[sides[k].to], c->right) + c->shift,
                    ss_dot3(s->rest[sides[k].to], c->up));
        }
        k += is_pair ? 2 : 1;
    }
    for (int32_t k = 0; k <= s->ring_count && s->ring_count > 0; ++k) {
        const double *p = s->rest[s->ring[k % s->ring_count]];
        fprintf(file, "%.5g %.5g\n", ss_dot3(p, c->right) + c->shift, ss_dot3(p, c->up));
    }
    fputs("\n", file);
    free(sides);
    return true;
}

/* The arrow of a push, and the ball. */
static void put_marks(FILE *file, const ss_surface_picture *s, const canvas *c, double size)
{
    for (int32_t k = 0; k < s->mark_count; ++k) {
        double p[3];
        place(s, s->mark[k], true, p);
        fputs("set object circle at ", file);
        put_point(file, c, p, "");
        fprintf(file, " size %.5g front fs solid noborder fc rgb '#b00020'\n", 0.007 * size);
    }
    if (s->pushed >= 0) {
        double tip[3], tail[3], direction[3];
        place(s, s->pushed, true, tip);
        ss_copy3(direction, s->push);
        ss_normalize3(direction);
        ss_madd3(tail, tip, -0.22 * size, direction);
        fputs("set arrow from ", file);
        put_point(file, c, tail, " to ");
        put_point(file, c, tip, " front lw 2.5 lc rgb '#b00020' head filled size graph 0.012,20\n");
    }
    if (s->ball_radius > 0.0) {
        fputs("set object circle at ", file);
        put_point(file, c, s->ball, "");
        fprintf(file,
                " size %.5g front fs transparent solid 0.35 border lc rgb '#203080' "
                "fc rgb '#5070d0'\n",
                s->ball_radius);
    }
}

softsim_status ss_surface_picture_draw(ss_paper *paper, const char *name, const char *caption,
                                       const ss_surface_picture *shape,
                                       const ss_surface_picture_view *view, int32_t view_count,
                                       softsim_error *error)
{
    return ss_surface_picture_put(&paper->page, name, caption, shape, view, view_count, error);
}

int32_t (*ss_surface_faces(int32_t triangle_count, const int32_t (*triangle)[3]))[4]
{
    int32_t(*face)[4] = calloc((size_t)triangle_count, sizeof *face);
    for (int32_t t = 0; face != NULL && t < triangle_count; ++t) {
        memcpy(face[t], triangle[t], sizeof triangle[t]);
        face[t][3] = -1;
    }
    return face;
}

softsim_status ss_surface_picture_put(ss_page *page, const char *name, const char *caption,
                                      const ss_surface_picture *shape,
                                      const ss_surface_picture_view *view, int32_t view_count,
                                      softsim_error *error)
{
    enum { MAX_VIEWS = 4 };
    canvas c[MAX_VIEWS];
    ss_output script;
    const int32_t count = view_count < MAX_VIEWS ? view_count : MAX_VIEWS;
    double place_x = 0.0, low = (double)INFINITY, high = -(double)INFINITY, size = 0.0;
    bool is_good = true;
    for (int32_t v = 0; v < count; ++v) {
        set_axes(&view[v], &c[v]);
        set_bounds(shape, &c[v]);
        size = fmax(size, fmax(c[v].high[0] - c[v].low[0], c[v].high[1] - c[v].low[1]));
        c[v].shift = place_x - c[v].low[0];
        place_x += (c[v].high[0] - c[v].low[0]) + gap_share * size;
        low = fmin(low, c[v].low[1]);
        high = fmax(high, c[v].high[1]);
    }
    low -= 0.04 * size;
    high += 0.20 * size; /* arrows and labels */
    const double height = fmax(160.0, 1000.0 * (high - low) / (place_x + 0.02 * size));
    const softsim_status status =
        ss_plot_open_dots(&script, page->folder, name, 1000, (int32_t)height, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    FILE *file = script.file;
    fprintf(file,
            "set size ratio -1\nset margins 0,0,0,0\nunset border\n"
            "unset tics\nunset key\nset xrange [%.5g:%.5g]\nset yrange [%.5g:%.5g]\n",
            -0.02 * size, place_x, low, high);
    for (int32_t v = 0; v < count && is_good; ++v) {
        is_good = put_faces(file, shape, &c[v]);
        put_marks(file, shape, &c[v], size);
        fprintf(file, "set label '%s' at %.5g,%.5g left front tc rgb 'grey30'\n", view[v].label,
                c[v].low[0] + c[v].shift, high - 0.05 * size);
    }
    fputs("$outline << EOD\n", file);
    for (int32_t v = 0; v < count && is_good; ++v) {
        is_good = put_outline(file, shape, &c[v]);
    }
    fputs("EOD\nplot $outline with lines lw 1.2 dt 2 lc rgb '#404040'\n", file);
    if (!is_good) {
        ss_output_abandon(&script);
        return ss_memory_fault(error);
    }
    return ss_page_plot(page, &script, name, caption, error);
}
