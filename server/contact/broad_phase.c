/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Which triangles a tool may reach in a step.
 *
 * From the tree: the triangles whose ball comes within delta + node_slack + path_slack of the ball
 * of the tool swept from pose to pose, and of the tool itself halfway, widened by how far any point
 * of it is from there at any time. A triangle's ball (centroid of its corners, its grid points and
 * corners inside) is exact for the displacement at the broad phase. The node_slack lets nodes move,
 * the path_slack the tool: while both last, the following steps keep the broad phase (measured,
 * 1212 nodes, R = h: 13 us a broad phase, 0.2 us where it is kept).
 */
#include <math.h>
#include <string.h>

#include "contact/internal.h"

/* ---- sets of nodes ---- */

void ss_contact_query_mark(ss_contact_query *query, ss_mark_range *range, int32_t node)
{
    const int32_t word = node / 64;
    query->mark[word] |= (uint64_t)1 << (node % 64);
    range->low = word < range->low ? word : range->low;
    range->high = word > range->high ? word : range->high;
}

int32_t ss_contact_query_take_marked(ss_contact_query *query, const ss_mark_range *range,
                                     int32_t *out_node)
{
    int32_t count = 0;
    for (int32_t word = range->low; word <= range->high; ++word) {
        for (uint64_t bits = query->mark[word]; bits != 0; bits &= bits - 1) {
            out_node[count++] = 64 * word + __builtin_ctzll(bits);
        }
        query->mark[word] = 0;
    }
    return count;
}

/* ---- search ---- */

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
    double middle[3], half[3];
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
static void add_leaf(ss_contact_query *query, const ss_real *u, double reach,
                     const ss_frame *middle, int32_t leaf, ss_mark_range *range)
{
    const ss_surface *surface = query->surface;
    const int32_t end = ss_leaf_first_triangle(surface, leaf + 1);
    const double path_reach = query->bounding_radius + reach;
    const ss_real middle_reach = (ss_real)(query->half_motion + reach);
    for (int32_t t = ss_leaf_first_triangle(surface, leaf); t < end; ++t) {
        ss_candidate *candidate = &query->candidate[query->candidate_count];
        set_candidate(surface, t, u, candidate);
        const double centre[3] = {(double)candidate->centre[0], (double)candidate->centre[1],
                                  (double)candidate->centre[2]};
        if (distance_to_path(&query->sweep, centre) > path_reach + (double)candidate->radius ||
            ss_candidate_is_beyond(middle, candidate, middle_reach)) {
            continue;
        }
        query->candidate_count++;
        for (int32_t c = surface->control_first[t]; c < surface->control_first[t + 1]; ++c) {
            ss_contact_query_mark(query, range, surface->control[c]);
        }
    }
}

static void search_tree(ss_contact_query *query, const ss_real *u)
{
    const ss_surface *surface = query->surface;
    const double reach = query->delta + query->node_slack + query->path_slack + query->margin;
    const double tree_reach = query->bounding_radius + reach + surface->moved;
    ss_mark_range range = {INT32_MAX, -1};
    ss_frame middle;
    int32_t stack[SS_TREE_STACK];
    int depth = 0;
    ss_contact_query_frame(query, &query->middle, &middle);
    query->candidate_count = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const int32_t at = stack[--depth];
        if (is_clear(&query->sweep, tree_reach, &surface->box[at])) {
            continue;
        }
        if (at >= surface->leaf_count - 1) {
            add_leaf(query, u, reach, &middle, at - (surface->leaf_count - 1), &range);
        } else {
            stack[depth++] = 2 * at + 2;
            stack[depth++] = 2 * at + 1;
        }
    }
    query->candidate_node_count =
        ss_contact_query_take_marked(query, &range, query->candidate_node);
    for (int32_t i = 0; i < query->candidate_node_count; ++i) {
        memcpy(query->candidate_u + 4 * (int64_t)i, u + 4 * (int64_t)query->candidate_node[i],
               4 * sizeof(ss_real));
    }
}

ss_real ss_contact_query_moved(const ss_contact_query *query, const ss_real *u)
{
    ss_real largest = 0;
    for (int32_t i = 0; i < query->candidate_node_count; ++i) {
        const ss_wide move = *(const ss_wide_loose *)(u + 4 * (int64_t)query->candidate_node[i]) -
                             *(const ss_wide_loose *)(query->candidate_u + 4 * (int64_t)i);
        const ss_real square = ss_wide_square(&move);
        largest = square > largest || isnan(square) ? square : largest;
    }
    return ss_real_root(largest);
}

/* Does the last broad phase cover this path too? Distance to a path and angle from an orientation
 * are convex along the new path, so its ends decide. */
static bool is_covered(const ss_contact_query *query, const ss_tool_pose *pose)
{
    double x[3];
    ss_sub3(x, pose->position, query->surface->centre);
    return distance_to_path(&query->sweep, x) <= query->path_slack &&
           ss_tool_motion_bound(&query->shape, &query->middle, pose) <=
               query->half_motion + query->path_slack;
}

static bool is_finite_pose(const ss_tool_pose *pose)
{
    return ss_is_finite(pose->position, 3) && ss_is_finite(pose->orientation, 4);
}

static void forget(ss_contact_query *query)
{
    query->has_candidates = false;
    query->candidate_count = 0;
    query->candidate_node_count = 0;
}

/* Nodes that were out of reach are not looked at: between two looks at the same fit none has moved
 * further than the sum of what the looks found. */
static bool is_still_complete(const ss_contact_query *query)
{
    const ss_surface *surface = query->surface;
    return query->fit == surface->fit &&
           query->fit_moved + surface->moved <= 0.5 * query->node_slack;
}

bool ss_contact_query_is_covered(const ss_contact_query *query, const ss_real *u,
                                 const ss_tool_pose *from, const ss_tool_pose *to)
{
    return query->has_candidates && is_covered(query, from) && is_covered(query, to) &&
           is_still_complete(query) &&
           (double)ss_contact_query_moved(query, u) <= 0.5 * query->node_slack;
}

int32_t ss_contact_query_broad_phase(ss_contact_query *query, const ss_real *u,
                                     const ss_tool_pose *from, const ss_tool_pose *to)
{
    query->weight_count = 0;
    query->source_count = 0;
    query->sample_count = 0;
    query->group_count = 0;
    query->dropped_from = 0;
    if (!is_finite_pose(from) || !is_finite_pose(to)) {
        forget(query);
        return 0;
    }
    if (!ss_contact_query_is_covered(query, u, from, to)) {
        ss_sub3(query->sweep.start, from->position, query->surface->centre);
        ss_sub3(query->sweep.along, to->position, from->position);
        query->sweep.square = ss_dot3(query->sweep.along, query->sweep.along);
        ss_tool_pose_blend(from, to, 0.5, &query->middle);
        query->half_motion = 0.5 * ss_tool_motion_bound(&query->shape, from, to);
        search_tree(query, u);
        query->has_candidates = true;
        query->fit = query->surface->fit;
        query->fit_moved = query->surface->moved;
    }
    query->dropped_from = query->candidate_count;
    return query->candidate_count;
}

int32_t ss_contact_query_candidate_nodes(const ss_contact_query *query, const int32_t **out_node)
{
    *out_node = query->candidate_node;
    return query->candidate_node_count;
}
