/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * One tool on the surface: who is in reach, source weights, penalty.
 *
 *   weights  w_i = sum_s A_s b_si phi(d_s),  phi = (1 - d/delta)+^2,
 *            f_s = -A_s phi'(d_s) (sum_i b_si mu_i) n_s,  phi' = -2 (1 - d/delta)+ / delta
 *   penalty  U = 1/2 kc sum_q A_q (-d_q)+^2,  f_q = A_q kc (-d_q)+ n_q on the nodes by B_qi
 *   tool     force -sum f, torque -sum r x f, r from the tool's origin
 *
 * All are functions of node positions and pose alone; what the gather leaves out has d > 0 (or
 * > delta), contributes exactly nothing, and the rest is summed in the surface's fixed order: the
 * bits do not depend on the gather's radius nor on what is culled. Two culls, both rigorous: the
 * distance is 1-Lipschitz, and since rows are convex no sample moves further than M, the largest
 * motion of a node in reach since the gather. So a triangle whose ball at the gather (centre c,
 * radius r) has d(c) > r + M holds no active sample; a facet the same with its radius + 2 M. A
 * gather is made with some room and serves the following steps until the tool or a node in reach
 * has left that room (measured, 1212 nodes, R = h: 13 us a gather, 0.2 us where it is kept).
 *
 * Sphere and capsule are computed in ss_real here, the others in double by ss_shape_distance.
 */
#include "contact/touch.h"

#include <math.h>
#include <string.h>

#include "contact/shape.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* ---- the tool's frame ----------------------------------------------------------------------- */

void ss_frame_set(ss_frame *frame, const ss_touch *touch, const ss_tool_pose *pose)
{
    static const double z[3] = {0.0, 0.0, 1.0};
    double axis[3];
    *frame = (ss_frame){.shape = &touch->shape};
    memcpy(frame->orientation, pose->orientation, sizeof frame->orientation);
    ss_rotate(axis, pose->orientation, z);
    for (int k = 0; k < 3; ++k) {
        frame->origin[k] = (ss_real)(pose->position[k] - touch->surface->centre[k]);
        frame->axis[k] = (ss_real)axis[k];
    }
    frame->is_round = touch->shape.kind == SS_SHAPE_SPHERE || touch->shape.kind == SS_SHAPE_CAPSULE;
    frame->core = touch->shape.kind == SS_SHAPE_CAPSULE ? (ss_real)touch->shape.half_length : 0;
    frame->radius = (ss_real)touch->shape.radius;
}

/* Vector from the nearest point of a round tool's core. */
static inline void from_core(const ss_frame *frame, const ss_wide *r, ss_wide *out)
{
    *out = *r;
    if (frame->core > 0) {
        const ss_real *a = frame->axis;
        ss_real t = (*r)[0] * a[0] + (*r)[1] * a[1] + (*r)[2] * a[2];
        t = t > frame->core ? frame->core : t < -frame->core ? -frame->core : t;
        *out -= (ss_wide){t * a[0], t * a[1], t * a[2], 0};
    }
}

static inline ss_real square_of(const ss_wide *a)
{
    return (*a)[0] * (*a)[0] + (*a)[1] * (*a)[1] + (*a)[2] * (*a)[2];
}

static inline ss_real root(ss_real x)
{
#ifdef SOFTSIM_DOUBLE
    return sqrt(x);
#else
    return sqrtf(x);
#endif
}

/* Unit vector along `r` of length `length`; a fixed one on the core. */
static inline void set_normal(const ss_frame *frame, const ss_wide *r, ss_real length,
                              ss_real out[3])
{
    if (length > (ss_real)1e-15) { /* shorter ones have squares that underflow */
        const ss_real scale = 1 / length;
        out[0] = scale * (*r)[0];
        out[1] = scale * (*r)[1];
        out[2] = scale * (*r)[2];
    } else {
        double normal[3];
        double world[3];
        const double centre[3] = {0.0, 0.0, 0.0};
        ss_shape_distance(frame->shape, centre, normal);
        ss_rotate(world, frame->orientation, normal);
        for (int k = 0; k < 3; ++k) {
            out[k] = (ss_real)world[k];
        }
    }
}

/* The distance to a round tool's core, less its radius. */
static double round_distance(const ss_frame *frame, const double r[3], double out_normal[3])
{
    const double axis[3] = {(double)frame->axis[0], (double)frame->axis[1], (double)frame->axis[2]};
    const double core = (double)frame->core;
    const double along = ss_dot3(r, axis);
    const double t = along > core ? core : along < -core ? -core : along;
    double q[3];
    ss_madd3(q, r, -t, axis);
    const double length = ss_norm3(q);
    if (out_normal != NULL) {
        ss_real normal[3];
        const ss_wide from = {(ss_real)q[0], (ss_real)q[1], (ss_real)q[2], 0};
        set_normal(frame, &from, (ss_real)length, normal);
        ss_set3(out_normal, (double)normal[0], (double)normal[1], (double)normal[2]);
    }
    return length - (double)frame->radius;
}

double ss_frame_distance(const ss_frame *frame, const ss_real r[3], double out_normal[3])
{
    const double world[3] = {(double)r[0], (double)r[1], (double)r[2]};
    double local[3];
    double normal[3];
    if (frame->is_round) {
        return round_distance(frame, world, out_normal);
    }
    ss_rotate_back(local, frame->orientation, world);
    const double d = ss_shape_distance(frame->shape, local, normal);
    if (out_normal != NULL) {
        ss_rotate(out_normal, frame->orientation, normal);
    }
    return d;
}

/* Is the point at `r` further from the tool than `distance`? False when not a number. */
static inline bool is_beyond(const ss_frame *frame, const ss_wide *r, ss_real distance)
{
    if (frame->is_round) {
        ss_wide q;
        from_core(frame, r, &q);
        const ss_real reach = frame->radius + distance;
        return square_of(&q) > reach * reach;
    }
    const ss_real at[3] = {(*r)[0], (*r)[1], (*r)[2]};
    return ss_frame_distance(frame, at, NULL) > (double)distance;
}

/* The distance where it is less than `limit`, with its gradient; else false. */
static inline bool find_distance(const ss_frame *frame, const ss_wide *r, ss_real limit,
                                 ss_real *out_d, ss_real out_normal[3])
{
    if (frame->is_round) {
        ss_wide q;
        from_core(frame, r, &q);
        const ss_real reach = frame->radius + limit;
        const ss_real square = square_of(&q);
        if (!(square < reach * reach)) {
            return false;
        }
        const ss_real length = root(square);
        *out_d = length - frame->radius;
        set_normal(frame, &q, length, out_normal);
        return *out_d < limit;
    }
    const double world[3] = {(double)(*r)[0], (double)(*r)[1], (double)(*r)[2]};
    double local[3];
    double normal[3];
    ss_rotate_back(local, frame->orientation, world);
    *out_d = (ss_real)ss_shape_distance(frame->shape, local, normal);
    if (!(*out_d < limit)) {
        return false;
    }
    ss_rotate(local, frame->orientation, normal);
    for (int k = 0; k < 3; ++k) {
        out_normal[k] = (ss_real)local[k];
    }
    return true;
}

/* Is the ball about the candidate's triangle further than `distance` from the tool? */
static inline bool is_candidate_beyond(const ss_frame *frame, const ss_candidate *c,
                                       ss_real distance)
{
    const ss_wide r = {c->centre[0] - frame->origin[0], c->centre[1] - frame->origin[1],
                       c->centre[2] - frame->origin[2], 0};
    return is_beyond(frame, &r, c->radius + distance);
}

/* ---- create --------------------------------------------------------------------------------- */

/* How many of something of area `area` each can be within the tool at once, generously. */
static int32_t capacity_for(double radius, double area, int64_t total)
{
    const double estimate = 8.0 * 12.566370614359172954 * radius * radius / area;
    const double bounded = fmin(fmax(estimate, 4096.0), 1048576.0);
    return (int32_t)fmin(bounded, (double)total);
}

static bool allocate(ss_touch *touch)
{
    const ss_surface *surface = touch->surface;
    const size_t triangle_count = (size_t)surface->triangle_count;
    const size_t node_count = (size_t)surface->node_count;
    double area = 0.0;
    for (int32_t t = 0; t < surface->triangle_count; ++t) {
        area += (double)surface->area[t];
    }
    area = fmax(area / surface->triangle_count, 1e-30);
    const int64_t sample_total = ss_surface_sample_count(surface);
    touch->sample_capacity =
        capacity_for(touch->bounding_radius, area * surface->triangle_count / (double)sample_total,
                     sample_total);
    touch->source_capacity =
        capacity_for(touch->bounding_radius + touch->delta, area, surface->triangle_count);
    touch->candidate = ss_memory_get(triangle_count, sizeof(ss_candidate));
    touch->reach = ss_memory_get(node_count, sizeof(int32_t));
    touch->reach_u = ss_memory_get(node_count, 4 * sizeof(ss_real));
    touch->mark = ss_memory_get(node_count / 64 + 1, sizeof(uint64_t));
    touch->node_weight = ss_memory_get(node_count, sizeof(double));
    touch->node_slot = ss_memory_get(node_count, sizeof(int32_t));
    touch->weight_node = ss_memory_get(node_count, sizeof(int32_t));
    touch->weight = ss_memory_get(node_count, sizeof(double));
    touch->source = ss_memory_get((size_t)touch->source_capacity, sizeof(ss_source));
    touch->sample = ss_memory_get((size_t)touch->sample_capacity, sizeof(ss_sample));
    touch->group = ss_memory_get(triangle_count, sizeof(ss_group));
    return touch->candidate != NULL && touch->reach != NULL && touch->reach_u != NULL &&
           touch->mark != NULL && touch->node_weight != NULL && touch->node_slot != NULL &&
           touch->weight_node != NULL && touch->weight != NULL && touch->source != NULL &&
           touch->sample != NULL && touch->group != NULL;
}

softsim_status ss_touch_create(const ss_surface *surface, const ss_shape *shape,
                               const ss_touch_options *options, ss_touch **out_touch)
{
    *out_touch = NULL;
    const double radius = ss_shape_bounding_radius(shape);
    if (!(options->delta > 0.0 && isfinite(options->delta) && options->stiffness >= 0.0 &&
          isfinite(options->stiffness) && radius > 0.0 && isfinite(radius))) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    ss_touch *touch = ss_memory_get(1, sizeof(ss_touch));
    if (touch == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    touch->surface = surface;
    touch->shape = *shape;
    touch->delta = options->delta;
    touch->stiffness = options->stiffness;
    touch->slack = 0.25 * options->delta;
    touch->spare = 0.25 * options->delta;
    touch->bounding_radius = radius;
    touch->margin = (sizeof(ss_real) == 4 ? 1e-5 : 1e-12) * (surface->size + radius);
    double low;
    double high;
    ss_shape_span(shape, &low, &high);
    const double spacing = 0.5 * ss_shape_inradius(shape);
    touch->station_low = low;
    touch->station_high = high;
    touch->station_count = high - low < spacing ? 1 : high - low < 2.0 * spacing ? 2 : 4;
    if (!allocate(touch)) {
        ss_touch_destroy(&touch);
        return SOFTSIM_ERROR_MEMORY;
    }
    *out_touch = touch;
    return SOFTSIM_OK;
}

void ss_touch_destroy(ss_touch **touch)
{
    if (touch == NULL || *touch == NULL) {
        return;
    }
    ss_touch *t = *touch;
    void *memory[] = {t->candidate,   t->reach,     t->reach_u,     t->mark,
                      t->node_weight, t->node_slot, t->weight_node, t->weight,
                      t->source,      t->sample,    t->group};
    for (size_t i = 0; i < sizeof memory / sizeof memory[0]; ++i) {
        ss_memory_free(memory[i]);
    }
    ss_memory_free(t);
    *touch = NULL;
}

void ss_touch_set_stiffness(ss_touch *touch, double stiffness_n_per_m3)
{
    touch->stiffness = stiffness_n_per_m3;
}

/* ---- sets of nodes -------------------------------------------------------------------------- */

/* A range of words of the mark bits that may hold set bits. */
typedef struct mark_range {
    int32_t low, high;
} mark_range;

static inline void mark_node(ss_touch *touch, mark_range *range, int32_t node)
{
    const int32_t word = node / 64;
    touch->mark[word] |= (uint64_t)1 << (node % 64);
    range->low = word < range->low ? word : range->low;
    range->high = word > range->high ? word : range->high;
}

/* Writes the marked nodes in increasing order and clears the marks. */
static int32_t take_marked(ss_touch *touch, const mark_range *range, int32_t *out_node)
{
    int32_t count = 0;
    for (int32_t word = range->low; word <= range->high; ++word) {
        for (uint64_t bits = touch->mark[word]; bits != 0; bits &= bits - 1) {
            out_node[count++] = 64 * word + __builtin_ctzll(bits);
        }
        touch->mark[word] = 0;
    }
    return count;
}

/* ---- gather --------------------------------------------------------------------------------- */

static double distance_to_path(const ss_sweep *s, const double x[3])
{
    double r[3];
    ss_sub3(r, x, s->start);
    const double along = s->square > 0.0 ? ss_dot3(r, s->along) / s->square : 0.0;
    const double t = along < 0.0 ? 0.0 : along > 1.0 ? 1.0 : along;
    ss_madd3(r, r, -t, s->along);
    return ss_norm3(r);
}

/* Rejects a box further than `radius` from the path's own box or, as a ball, from the path. */
static bool is_clear(const ss_sweep *s, double radius, const ss_box *box)
{
    double middle[3];
    double half[3];
    for (int k = 0; k < 3; ++k) {
        const double low = (double)box->low[k];
        const double high = (double)box->high[k];
        const double path_end = s->start[k] + s->along[k];
        const double path_low = path_end < s->start[k] ? path_end : s->start[k];
        const double path_high = path_end < s->start[k] ? s->start[k] : path_end;
        if (low > path_high + radius || high < path_low - radius) {
            return true;
        }
        middle[k] = 0.5 * (low + high);
        half[k] = 0.5 * (high - low);
    }
    return distance_to_path(s, middle) > radius + ss_norm3(half);
}

/* The ball of a triangle in its present shape: about the centroid of its corners. */
static void set_candidate(const ss_surface *surface, int32_t t, const ss_real *u, ss_candidate *out)
{
    const int32_t *corner = surface->control + surface->control_first[t];
    ss_wide at[3];
    for (int k = 0; k < 3; ++k) {
        at[k] = *(const ss_wide_loose *)(surface->rest + 4 * (int64_t)corner[k]) +
                *(const ss_wide_loose *)(u + 4 * (int64_t)corner[k]);
    }
    const ss_wide centre = (at[0] + at[1] + at[2]) / 3;
    ss_wide point[SS_GRID_ROW];
    ss_real square = 0;
    ss_surface_points(surface, t, u, &centre, point);
    for (int p = 0; p < SS_GRID_POINTS; ++p) {
        const ss_real r = square_of(&point[p]);
        square = r > square ? r : square;
    }
    for (int k = 0; k < 3; ++k) {
        const ss_wide from_centre = at[k] - centre;
        const ss_real r = square_of(&from_centre);
        square = r > square ? r : square;
    }
    *out = (ss_candidate){.centre = {centre[0], centre[1], centre[2]},
                          .radius = root(square),
                          .facet_radius = -1,
                          .triangle = t};
}

/* Appends the triangles of a leaf that the tool may reach. */
static void gather_leaf(ss_touch *touch, const ss_real *u, double reach, const ss_frame *middle,
                        int32_t leaf, mark_range *range)
{
    const ss_surface *surface = touch->surface;
    const int32_t end = ss_leaf_first_triangle(surface, leaf + 1);
    const double path_reach = touch->bounding_radius + reach;
    const ss_real middle_reach = (ss_real)(touch->half_motion + reach);
    for (int32_t t = ss_leaf_first_triangle(surface, leaf); t < end; ++t) {
        ss_candidate *candidate = &touch->candidate[touch->candidate_count];
        set_candidate(surface, t, u, candidate);
        const double centre[3] = {(double)candidate->centre[0], (double)candidate->centre[1],
                                  (double)candidate->centre[2]};
        if (distance_to_path(&touch->sweep, centre) > path_reach + (double)candidate->radius ||
            is_candidate_beyond(middle, candidate, middle_reach)) {
            continue;
        }
        touch->candidate_count++;
        for (int32_t c = surface->control_first[t]; c < surface->control_first[t + 1]; ++c) {
            mark_node(touch, range, surface->control[c]);
        }
    }
}

static void gather_tree(ss_touch *touch, const ss_real *u)
{
    const ss_surface *surface = touch->surface;
    const double reach = touch->delta + touch->slack + touch->spare + touch->margin;
    const double tree_reach = touch->bounding_radius + reach + surface->moved;
    mark_range range = {INT32_MAX, -1};
    ss_frame middle;
    int32_t stack[SS_TREE_STACK];
    int depth = 0;
    ss_frame_set(&middle, touch, &touch->middle);
    touch->candidate_count = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const int32_t at = stack[--depth];
        if (is_clear(&touch->sweep, tree_reach, &surface->box[at])) {
            continue;
        }
        if (at >= surface->leaf_count - 1) {
            gather_leaf(touch, u, reach, &middle, at - (surface->leaf_count - 1), &range);
        } else {
            stack[depth++] = 2 * at + 2;
            stack[depth++] = 2 * at + 1;
        }
    }
    touch->reach_count = take_marked(touch, &range, touch->reach);
    for (int32_t i = 0; i < touch->reach_count; ++i) {
        memcpy(touch->reach_u + 4 * (int64_t)i, u + 4 * (int64_t)touch->reach[i],
               4 * sizeof(ss_real));
    }
}

/* How far a node in reach has moved since the gather; NaN when one is not finite. */
static ss_real moved_since_gather(const ss_touch *touch, const ss_real *u)
{
    ss_real largest = 0;
    for (int32_t i = 0; i < touch->reach_count; ++i) {
        const ss_wide move = *(const ss_wide_loose *)(u + 4 * (int64_t)touch->reach[i]) -
                             *(const ss_wide_loose *)(touch->reach_u + 4 * (int64_t)i);
        const ss_real square = square_of(&move);
        largest = square > largest || isnan(square) ? square : largest;
    }
    return root(largest);
}

/* Does the last gather cover this path too? Distance to a path and angle from an orientation are
 * convex along the new path, so its ends decide. */
static bool is_covered(const ss_touch *touch, const ss_tool_pose *pose)
{
    double x[3];
    ss_sub3(x, pose->position, touch->surface->centre);
    return distance_to_path(&touch->sweep, x) <= touch->spare &&
           ss_tool_motion_bound(&touch->shape, &touch->middle, pose) <=
               touch->half_motion + touch->spare;
}

static bool is_finite_pose(const ss_tool_pose *pose)
{
    return ss_is_finite(pose->position, 3) && ss_is_finite(pose->orientation, 4);
}

static void forget(ss_touch *touch)
{
    touch->is_gathered = false;
    touch->candidate_count = 0;
    touch->reach_count = 0;
}

int32_t ss_touch_gather(ss_touch *touch, const ss_real *u, const ss_tool_pose *from,
                        const ss_tool_pose *to)
{
    touch->weight_count = 0;
    touch->source_count = 0;
    touch->sample_count = 0;
    touch->group_count = 0;
    touch->dropped_from = 0;
    if (!is_finite_pose(from) || !is_finite_pose(to)) {
        forget(touch);
        return 0;
    }
    if (!touch->is_gathered || !is_covered(touch, from) || !is_covered(touch, to) ||
        !((double)moved_since_gather(touch, u) <= 0.5 * touch->slack)) {
        ss_sub3(touch->sweep.start, from->position, touch->surface->centre);
        ss_sub3(touch->sweep.along, to->position, from->position);
        touch->sweep.square = ss_dot3(touch->sweep.along, touch->sweep.along);
        ss_tool_pose_blend(from, to, 0.5, &touch->middle);
        touch->half_motion = 0.5 * ss_tool_motion_bound(&touch->shape, from, to);
        gather_tree(touch, u);
        touch->is_gathered = true;
    }
    touch->dropped_from = touch->candidate_count;
    return touch->candidate_count;
}

int32_t ss_touch_reach(const ss_touch *touch, const int32_t **out_node)
{
    *out_node = touch->reach;
    return touch->reach_count;
}

/* ---- source weights ------------------------------------------------------------------------- */

/* Weights of the corners at weight sample s: corner samples 0..2 at (2/3, 1/6, 1/6), the middle. */
static inline void weight_row(int s, ss_real out[3])
{
    for (int k = 0; k < 3; ++k) {
        out[k] = s == 3 ? (ss_real)1 / 3 : k == s ? (ss_real)2 / 3 : (ss_real)1 / 6;
    }
}

/* Adds the weights of one triangle; keeps it when it has any. */
static void weigh_triangle(ss_touch *touch, const ss_frame *frame, const ss_real *u, int32_t t,
                           mark_range *range)
{
    const ss_surface *surface = touch->surface;
    const int32_t *corner = surface->control + surface->control_first[t];
    const int count = surface->grid.weight_count;
    const double area = (double)surface->area[t] / count;
    ss_source *source = &touch->source[touch->source_count];
    double share[3] = {0.0, 0.0, 0.0};
    ss_wide at[3];
    for (int k = 0; k < 3; ++k) {
        at[k] = *(const ss_wide_loose *)(surface->rest + 4 * (int64_t)corner[k]) +
                *(const ss_wide_loose *)(u + 4 * (int64_t)corner[k]) - frame->origin;
    }
    for (int s = 0; s < count; ++s) {
        ss_real row[3];
        ss_real d;
        weight_row(count == 1 ? 3 : s, row);
        const ss_wide r = row[0] * at[0] + row[1] * at[1] + row[2] * at[2];
        source->slope[s] = 0;
        if (!find_distance(frame, &r, (ss_real)touch->delta, &d, source->n[s])) {
            continue;
        }
        const double g = 1.0 - (double)d / touch->delta;
        source->slope[s] = (ss_real)(2.0 * area * g / touch->delta);
        for (int k = 0; k < 3; ++k) {
            source->r[s][k] = r[k];
            share[k] += area * g * g * (double)row[k];
        }
    }
    if (share[0] > 0.0) {
        source->triangle = t;
        touch->source_count++;
        for (int k = 0; k < 3; ++k) {
            touch->node_weight[corner[k]] += share[k];
            mark_node(touch, range, corner[k]);
        }
    }
}

int32_t ss_touch_weigh(ss_touch *touch, const ss_real *u, const uint8_t *is_source,
                       const ss_tool_pose *pose, const int32_t **out_node,
                       const double **out_weight, double *out_total)
{
    const ss_surface *surface = touch->surface;
    mark_range range = {INT32_MAX, -1};
    ss_frame frame;
    ss_frame_set(&frame, touch, pose);
    const ss_real extra = (ss_real)(touch->delta + touch->margin) + moved_since_gather(touch, u);
    touch->source_count = 0;
    for (int32_t i = 0; i < touch->candidate_count; ++i) {
        const ss_candidate *c = &touch->candidate[i];
        if (touch->source_count < touch->source_capacity &&
            !is_candidate_beyond(&frame, c, extra)) {
            weigh_triangle(touch, &frame, u, c->triangle, &range);
        }
    }

    /* The list of nodes, and where it holds the corners of each triangle. */
    int32_t *node = touch->weight_node;
    const int32_t marked = take_marked(touch, &range, node);
    int32_t count = 0;
    double total = 0.0;
    for (int32_t i = 0; i < marked; ++i) {
        const bool is_used = is_source == NULL || is_source[node[i]];
        touch->weight[count] = touch->node_weight[node[i]];
        touch->node_weight[node[i]] = 0.0;
        touch->node_slot[node[i]] = is_used ? count : -1;
        if (is_used) {
            total += touch->weight[count];
            node[count++] = node[i];
        }
    }
    for (int32_t i = 0; i < touch->source_count; ++i) {
        ss_source *source = &touch->source[i];
        const int32_t *corner = surface->control + surface->control_first[source->triangle];
        for (int k = 0; k < 3; ++k) {
            source->slot[k] = touch->node_slot[corner[k]];
        }
    }
    touch->weight_count = count;
    *out_node = node;
    *out_weight = touch->weight;
    *out_total = total;
    return count;
}

/* Adds `sum` (force on the tissue) and its moment to the tool with opposite sign. */
static void push_tool(const double sum[3], const double moment[3], double tool_force[3],
                      double tool_torque[3])
{
    ss_sub3(tool_force, tool_force, sum);
    ss_sub3(tool_torque, tool_torque, moment);
}

void ss_touch_weight_forces(const ss_touch *touch, const double *mu, ss_real *force,
                            double tool_force[3], double tool_torque[3])
{
    const ss_surface *surface = touch->surface;
    const int count = surface->grid.weight_count;
    double sum[3] = {0.0, 0.0, 0.0};
    double moment[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; i < touch->source_count; ++i) {
        const ss_source *source = &touch->source[i];
        const int32_t *corner = surface->control + surface->control_first[source->triangle];
        double at[3];
        double on_node[3][3] = {{0.0}};
        for (int k = 0; k < 3; ++k) {
            at[k] = source->slot[k] >= 0 ? mu[source->slot[k]] : 0.0;
        }
        for (int s = 0; s < count; ++s) {
            ss_real row[3];
            weight_row(count == 1 ? 3 : s, row);
            const double push =
                (double)source->slope[s] *
                ((double)row[0] * at[0] + (double)row[1] * at[1] + (double)row[2] * at[2]);
            if (push == 0.0) {
                continue;
            }
            double f[3];
            double r[3];
            double turn[3];
            for (int k = 0; k < 3; ++k) {
                f[k] = push * (double)source->n[s][k];
                r[k] = (double)source->r[s][k];
            }
            ss_add3(sum, sum, f);
            ss_cross3(turn, r, f);
            ss_add3(moment, moment, turn);
            for (int k = 0; k < 3; ++k) {
                ss_madd3(on_node[k], on_node[k], (double)row[k], f);
            }
        }
        for (int k = 0; k < 3; ++k) {
            for (int c = 0; c < 3; ++c) {
                force[4 * (int64_t)corner[k] + c] += (ss_real)on_node[k][c];
            }
        }
    }
    push_tool(sum, moment, tool_force, tool_torque);
}

/* ---- penalty -------------------------------------------------------------------------------- */

/* What a triangle's samples add up to. */
typedef struct penalty_sum {
    double force[3], moment[3], energy;
} penalty_sum;

/* The largest distance of a facet's point from the facet's centroid; NaN where one is. */
static ss_real facet_radius(const ss_grid *grid, const ss_wide point[SS_GRID_ROW])
{
    ss_real square = 0;
    for (int32_t f = 0; f < grid->facet_count; ++f) {
        const uint8_t *p = grid->facet[f];
        const ss_wide middle = (point[p[0]] + point[p[1]] + point[p[2]]) / 3;
        for (int k = 0; k < 3; ++k) {
            const ss_wide r = point[p[k]] - middle;
            const ss_real s = square_of(&r);
            square = s > square || isnan(s) ? s : square;
        }
    }
    return root(square);
}

/* Finds the samples of a triangle inside the tool. */
static int32_t find_samples(const ss_surface *surface, const ss_frame *frame,
                            const ss_wide point[SS_GRID_ROW], ss_real radius, ss_sample *out)
{
    const ss_grid *grid = &surface->grid;
    const ss_real third = (ss_real)1 / 3;
    int32_t count = 0;
    for (int32_t f = 0; f < grid->facet_count; ++f) {
        const uint8_t *p = grid->facet[f];
        const ss_wide middle = third * (point[p[0]] + point[p[1]] + point[p[2]]);
        if (is_beyond(frame, &middle, radius)) {
            continue;
        }
        for (int32_t part = 0; part < grid->part_count; ++part) {
            ss_wide r;
            ss_grid_sample(grid, f, part, point, &r);
            ss_sample *sample = &out[count];
            ss_real d;
            if (find_distance(frame, &r, 0, &d, sample->n)) {
                sample->r[0] = r[0];
                sample->r[1] = r[1];
                sample->r[2] = r[2];
                sample->depth = -d;
                sample->code = f * grid->part_count + part;
                count++;
            }
        }
    }
    return count;
}

/* Spreads samples' forces over the triangle's points and sums them up. */
static void sum_samples(const ss_grid *grid, const ss_sample *sample, int32_t count, ss_real scale,
                        ss_wide value[SS_GRID_ROW], penalty_sum *sum)
{
    ss_wide force = {0};
    ss_wide moment = {0};
    ss_real squares = 0;
    for (int p = 0; p < SS_GRID_ROW; ++p) {
        value[p] = (ss_wide){0};
    }
    for (int32_t i = 0; i < count; ++i) {
        const ss_sample *s = &sample[i];
        const uint8_t *p = grid->facet[s->code / grid->part_count];
        const ss_real *c = grid->part[s->code % grid->part_count];
        const ss_real push = scale * s->depth;
        const ss_wide f = {push * s->n[0], push * s->n[1], push * s->n[2], 0};
        value[p[0]] += c[0] * f;
        value[p[1]] += c[1] * f;
        value[p[2]] += c[2] * f;
        force += f;
        moment += (ss_wide){s->r[1] * f[2] - s->r[2] * f[1], s->r[2] * f[0] - s->r[0] * f[2],
                            s->r[0] * f[1] - s->r[1] * f[0], 0};
        squares += s->depth * s->depth;
    }
    for (int k = 0; k < 3; ++k) {
        sum->force[k] += (double)force[k];
        sum->moment[k] += (double)moment[k];
    }
    sum->energy += 0.5 * (double)scale * (double)squares;
}

/* kc A_q of a triangle's samples. */
static ss_real sample_scale(const ss_touch *touch, int32_t t)
{
    const ss_grid *grid = &touch->surface->grid;
    return (ss_real)(touch->stiffness * (double)touch->surface->area[t] /
                     (grid->facet_count * grid->part_count));
}

double ss_touch_penalty(ss_touch *touch, const ss_real *u, const ss_tool_pose *pose, ss_real *force,
                        double tool_force[3], double tool_torque[3])
{
    const ss_surface *surface = touch->surface;
    penalty_sum sum = {{0.0}, {0.0}, 0.0};
    ss_frame frame;
    ss_frame_set(&frame, touch, pose);
    const ss_real moved = moved_since_gather(touch, u) + (ss_real)touch->margin;
    const int32_t most = surface->grid.facet_count * surface->grid.part_count;
    ss_sample spare[SS_GRID_FACETS * SS_MAX_PARTS * SS_MAX_PARTS];
    touch->sample_count = 0;
    touch->group_count = 0;
    touch->dropped_from = touch->candidate_count;
    for (int32_t i = 0; i < touch->candidate_count; ++i) {
        ss_candidate *candidate = &touch->candidate[i];
        const int32_t t = candidate->triangle;
        if (is_candidate_beyond(&frame, candidate, moved)) {
            continue;
        }
        ss_wide point[SS_GRID_ROW];
        ss_surface_points(surface, t, u, &frame.origin, point);
        if (!(candidate->facet_radius >= 0)) {
            candidate->facet_radius = facet_radius(&surface->grid, point) + 2 * moved;
        }
        const bool is_kept = touch->sample_count + most <= touch->sample_capacity &&
                             touch->dropped_from == touch->candidate_count;
        ss_sample *sample = is_kept ? touch->sample + touch->sample_count : spare;
        const int32_t count =
            find_samples(surface, &frame, point, candidate->facet_radius + 2 * moved, sample);
        if (count == 0) {
            continue;
        }
        ss_wide value[SS_GRID_ROW];
        sum_samples(&surface->grid, sample, count, sample_scale(touch, t), value, &sum);
        if (force != NULL) {
            ss_surface_scatter(surface, t, value, force);
        }
        if (is_kept) {
            touch->group[touch->group_count++] = (ss_group){t, touch->sample_count, count};
            touch->sample_count += count;
        } else if (touch->dropped_from == touch->candidate_count) {
            touch->dropped_from = i;
        }
    }
    push_tool(sum.force, sum.moment, tool_force, tool_torque);
    return sum.energy;
}

/* ---- linearisation -------------------------------------------------------------------------- */

void ss_touch_tangent(const ss_touch *touch, const ss_real *du, const double dx[3], ss_real *dforce,
                      double dtool[3])
{
    const ss_surface *surface = touch->surface;
    const ss_grid *grid = &surface->grid;
    const ss_wide shift = {(ss_real)dx[0], (ss_real)dx[1], (ss_real)dx[2], 0};
    double sum[3] = {0.0, 0.0, 0.0};
    for (int32_t g = 0; g < touch->group_count; ++g) {
        const ss_group *group = &touch->group[g];
        const ss_real scale = sample_scale(touch, group->triangle);
        ss_wide move[SS_GRID_ROW];
        ss_wide value[SS_GRID_ROW];
        ss_wide on_tool = {0};
        for (int p = 0; p < SS_GRID_ROW; ++p) {
            move[p] = (ss_wide){0};
            value[p] = (ss_wide){0};
        }
        if (du != NULL) {
            ss_surface_moves(surface, group->triangle, du, move);
        }
        for (int32_t i = 0; i < group->count; ++i) {
            const ss_sample *s = &touch->sample[group->first + i];
            const uint8_t *p = grid->facet[s->code / grid->part_count];
            const ss_real *c = grid->part[s->code % grid->part_count];
            const ss_wide m = c[0] * move[p[0]] + c[1] * move[p[1]] + c[2] * move[p[2]] - shift;
            const ss_real push = -scale * (s->n[0] * m[0] + s->n[1] * m[1] + s->n[2] * m[2]);
            const ss_wide f = {push * s->n[0], push * s->n[1], push * s->n[2], 0};
            value[p[0]] += c[0] * f;
            value[p[1]] += c[1] * f;
            value[p[2]] += c[2] * f;
            on_tool += f;
        }
        for (int k = 0; k < 3; ++k) {
            sum[k] += (double)on_tool[k];
        }
        if (dforce != NULL) {
            ss_surface_scatter(surface, group->triangle, value, dforce);
        }
    }
    ss_sub3(dtool, dtool, sum);
}

/* Adds C^T value to doubles. */
static void scatter_scalar(const ss_surface *surface, int32_t t, const double value[SS_GRID_ROW],
                           double *out)
{
    const ss_patch *patch = &surface->patch[surface->patch_of[t]];
    const ss_real *row = surface->coefficient + (int64_t)patch->first * SS_GRID_ROW;
    const int32_t *control = surface->control + surface->control_first[t];
    for (int32_t i = 0; i < patch->control_count; ++i, row += SS_GRID_ROW) {
        double sum = 0.0;
        for (int p = 0; p < SS_GRID_POINTS; ++p) {
            sum += (double)row[p] * value[p];
        }
        out[control[i]] += sum;
    }
}

void ss_touch_diagonal(const ss_touch *touch, double *diagonal)
{
    const ss_surface *surface = touch->surface;
    const ss_grid *grid = &surface->grid;
    double value[SS_GRID_ROW];
    for (int32_t g = 0; g < touch->group_count; ++g) {
        const ss_group *group = &touch->group[g];
        const double scale = (double)sample_scale(touch, group->triangle);
        memset(value, 0, sizeof value);
        for (int32_t i = 0; i < group->count; ++i) {
            const int32_t code = touch->sample[group->first + i].code;
            for (int k = 0; k < 3; ++k) {
                value[grid->facet[code / grid->part_count][k]] +=
                    scale * (double)grid->part[code % grid->part_count][k];
            }
        }
        scatter_scalar(surface, group->triangle, value, diagonal);
    }
    /* Triangles whose samples were not kept count as wholly inside: the step bound stays safe. */
    for (int32_t i = touch->dropped_from; i < touch->candidate_count; ++i) {
        const int32_t t = touch->candidate[i].triangle;
        memset(value, 0, sizeof value);
        for (int32_t f = 0; f < grid->facet_count; ++f) {
            for (int k = 0; k < 3; ++k) {
                value[grid->facet[f][k]] +=
                    touch->stiffness * (double)surface->area[t] / (3.0 * grid->facet_count);
            }
        }
        scatter_scalar(surface, t, value, diagonal);
    }
}
