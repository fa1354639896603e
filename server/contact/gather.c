/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Which triangles a tool may reach in a step.
 *
 * From the tree: the triangles whose ball comes within delta + slack + spare of the ball of the
 * tool swept from pose to pose, and of the tool itself halfway, widened by how far any point of it
 * is from there at any time. A triangle's ball (centroid of its corners, its grid points and
 * corners inside) is exact for the displacement at the gather. The slack lets nodes move, the
 * spare lets the tool: while both last, the following steps keep the gather (measured, 1212 nodes,
 * R = h: 13 us a gather, 0.2 us where it is kept).
 */
#include <math.h>
#include <string.h>

#include "contact/touch.h"

/* ---- sets of nodes ---- */

void ss_touch_mark(ss_touch *touch, ss_mark_range *range, int32_t node)
{
    const int32_t word = node / 64;
    touch->mark[word] |= (uint64_t)1 << (node % 64);
    range->low = word < range->low ? word : range->low;
    range->high = word > range->high ? word : range->high;
}

int32_t ss_touch_take_marked(ss_touch *touch, const ss_mark_range *range, int32_t *out_node)
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

/* ---- gather ---- */

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
        const ss_real r = ss_wide_square(&point[p]);
        square = r > square ? r : square;
    }
    for (int k = 0; k < 3; ++k) {
        const ss_wide from_centre = at[k] - centre;
        const ss_real r = ss_wide_square(&from_centre);
        square = r > square ? r : square;
    }
    *out = (ss_candidate){.centre = {centre[0], centre[1], centre[2]},
                          .radius = ss_real_root(square),
                          .facet_radius = -1,
                          .triangle = t};
}

/* Appends the triangles of a leaf that the tool may reach. */
static void gather_leaf(ss_touch *touch, const ss_real *u, double reach, const ss_frame *middle,
                        int32_t leaf, ss_mark_range *range)
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
            ss_candidate_is_beyond(middle, candidate, middle_reach)) {
            continue;
        }
        touch->candidate_count++;
        for (int32_t c = surface->control_first[t]; c < surface->control_first[t + 1]; ++c) {
            ss_touch_mark(touch, range, surface->control[c]);
        }
    }
}

static void gather_tree(ss_touch *touch, const ss_real *u)
{
    const ss_surface *surface = touch->surface;
    const double reach = touch->delta + touch->slack + touch->spare + touch->margin;
    const double tree_reach = touch->bounding_radius + reach + surface->moved;
    ss_mark_range range = {INT32_MAX, -1};
    ss_frame middle;
    int32_t stack[SS_TREE_STACK];
    int depth = 0;
    ss_touch_frame(touch, &touch->middle, &middle);
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
    touch->reach_count = ss_touch_take_marked(touch, &range, touch->reach);
    for (int32_t i = 0; i < touch->reach_count; ++i) {
        memcpy(touch->reach_u + 4 * (int64_t)i, u + 4 * (int64_t)touch->reach[i],
               4 * sizeof(ss_real));
    }
}

ss_real ss_touch_moved(const ss_touch *touch, const ss_real *u)
{
    ss_real largest = 0;
    for (int32_t i = 0; i < touch->reach_count; ++i) {
        const ss_wide move = *(const ss_wide_loose *)(u + 4 * (int64_t)touch->reach[i]) -
                             *(const ss_wide_loose *)(touch->reach_u + 4 * (int64_t)i);
        const ss_real square = ss_wide_square(&move);
        largest = square > largest || isnan(square) ? square : largest;
    }
    return ss_real_root(largest);
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

/* Nodes that were out of reach are not looked at: between two looks at the same fit none has moved
 * further than the sum of what the looks found. */
static bool is_near_gathered(const ss_touch *touch)
{
    const ss_surface *surface = touch->surface;
    return touch->fit == surface->fit && touch->fit_moved + surface->moved <= 0.5 * touch->slack;
}

bool ss_touch_is_gathered(const ss_touch *touch, const ss_real *u, const ss_tool_pose *from,
                          const ss_tool_pose *to)
{
    return touch->is_gathered && is_covered(touch, from) && is_covered(touch, to) &&
           is_near_gathered(touch) && (double)ss_touch_moved(touch, u) <= 0.5 * touch->slack;
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
    if (!ss_touch_is_gathered(touch, u, from, to)) {
        ss_sub3(touch->sweep.start, from->position, touch->surface->centre);
        ss_sub3(touch->sweep.along, to->position, from->position);
        touch->sweep.square = ss_dot3(touch->sweep.along, touch->sweep.along);
        ss_tool_pose_blend(from, to, 0.5, &touch->middle);
        touch->half_motion = 0.5 * ss_tool_motion_bound(&touch->shape, from, to);
        gather_tree(touch, u);
        touch->is_gathered = true;
        touch->fit = touch->surface->fit;
        touch->fit_moved = touch->surface->moved;
    }
    touch->dropped_from = touch->candidate_count;
    return touch->candidate_count;
}

int32_t ss_touch_reach(const ss_touch *touch, const int32_t **out_node)
{
    *out_node = touch->reach;
    return touch->reach_count;
}
