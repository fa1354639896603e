/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The samples of a touch, reduced to the few contacts that the haptic loop gets.
 *
 * Touching: the samples' forces are shared among K stations, spread evenly along the tool's axis z
 * (K = 1 for a sphere or a short tool, else 2 or 4), by hat functions of the sample's z: shares
 * sum to 1, so the contacts' forces sum to the resultant, and all change smoothly as the tool
 * slides. Of a station, with sums over its shares of |f_q|:
 *   normal   of its resultant on the tool; force = |resultant|
 *   point    on a sphere X - (R - mean depth) n, on the line through its centre: no torque. Else
 *            the mean of the samples, moved along the tool's gradient to their mean depth, then
 *            across the force F onto its line of action, by F x (tau - r x F)/|F|^2 (some 1e-5 m;
 *            at most a quarter of the tool's inradius): r x F is then the samples' own moment tau
 *   S        mean of the nodes' rest curvature, turned by the least rotation that takes the mean
 *            rest normal to the normal, then projected on its tangent plane. The tissue's spin
 *            about its normal is not followed.
 * Not touching: the sample nearest to the tool, found through the tree, whose boxes are those of
 * the last refit (a step's own motion of the nodes is not in them); the normal is that of its facet
 * (the tool's own gradient jumps from sample to sample) unless tool and facet do not face each
 * other. Rejected: groups by clustering, which regroup from step to step and make the contacts
 * jump.
 */
#include <math.h>
#include <string.h>

#include "contact/internal.h"
#include "contact/shape.h"
#include "rt/vec.h"

enum { MAX_STATIONS = 4 };

/* Sums over samples, each weighted by the magnitude of its force. */
typedef struct tally {
    double force[3], moment[3]; /* on the tool, about its origin */
    double weight, depth, r[3], rest_normal[3], curvature[6];
    double friction[3], coefficient; /* on the tool; mu, weighted */
} tally;

/* ---- the tissue at a sample ---- */

/* Weights of the triangle's corners at a sample. */
static void sample_row(const ss_grid *grid, int32_t sample_index, double out[3])
{
    const uint8_t *p = grid->facet[sample_index / grid->part_count];
    const ss_real *c = grid->part[sample_index % grid->part_count];
    for (int k = 0; k < 3; ++k) {
        out[k] = (double)(c[0] * grid->bary[p[0]][k] + c[1] * grid->bary[p[1]][k] +
                          c[2] * grid->bary[p[2]][k]);
    }
}

static void add_tissue(const ss_surface *surface, int32_t t, int32_t sample_index, double weight,
                       tally *sum)
{
    const int32_t *fan = surface->fan[t];
    double row[3];
    sample_row(&surface->grid, sample_index, row);
    for (int k = 0; k < 3; ++k) {
        const double w = weight * row[k];
        for (int c = 0; c < 3; ++c) {
            sum->rest_normal[c] += w * (double)surface->fan_normal[fan[k]][c];
        }
        for (int c = 0; c < 6; ++c) {
            sum->curvature[c] += w * (double)surface->fan_curvature[fan[k]][c];
        }
    }
}

/* The matrix of the least rotation from unit vector a to unit vector b (any half turn when they
 * are opposite): R = 1 + [v] + [v]^2 / (1 + c), v = a x b, c = a . b. */
static void least_rotation(const double a[3], const double b[3], double out[3][3])
{
    const double c = ss_dot3(a, b);
    double v[3];
    ss_cross3(v, a, b);
    const double scale = 1.0 / fmax(1.0 + c, 1e-6);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            out[i][j] = scale * v[i] * v[j] + (i == j ? c : 0.0);
        }
    }
    out[0][1] -= v[2];
    out[1][0] += v[2];
    out[0][2] += v[1];
    out[2][0] -= v[1];
    out[1][2] -= v[0];
    out[2][1] += v[0];
}

/* S = Q K Qᵀ with Q = (1 - n nᵀ) R. */
static void set_curvature(const tally *sum, const double normal[3], double out[3][3])
{
    static const uint8_t packed[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    double rest[3], turn[3][3], half[3][3];
    ss_copy3(rest, sum->rest_normal);
    if (!(ss_normalize3(rest) > 0.0)) {
        ss_copy3(rest, normal);
    }
    least_rotation(rest, normal, turn);
    for (int j = 0; j < 3; ++j) {
        const double along =
            normal[0] * turn[0][j] + normal[1] * turn[1][j] + normal[2] * turn[2][j];
        for (int i = 0; i < 3; ++i) {
            turn[i][j] -= normal[i] * along;
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            half[i][j] = 0.0;
            for (int k = 0; k < 3; ++k) {
                half[i][j] += turn[i][k] * sum->curvature[packed[k][j]] / sum->weight;
            }
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
            out[i][j] = half[i][0] * turn[j][0] + half[i][1] * turn[j][1] + half[i][2] * turn[j][2];
            out[j][i] = out[i][j];
        }
    }
}

/* ---- touching ---- */

/* The shares of stations in a sample at height z on the tool. */
static void station_shares(const ss_contact_query *query, double z, double out[MAX_STATIONS])
{
    const int count = query->station_count;
    for (int k = 0; k < count; ++k) {
        out[k] = 0.0;
    }
    if (count == 1) {
        out[0] = 1.0;
        return;
    }
    const double span = query->station_high - query->station_low;
    const double at = fmax(0.0, fmin(1.0, (z - query->station_low) / span)) * (count - 1);
    const int below = at < count - 1 ? (int)at : count - 2;
    out[below] = 1.0 - (at - below);
    out[below + 1] = at - below;
}

/* The one with the largest share. */
static int32_t main_station(const ss_contact_query *query, double z)
{
    double share[MAX_STATIONS];
    int32_t most = 0;
    station_shares(query, z, share);
    for (int32_t k = 1; k < query->station_count; ++k) {
        most = share[k] > share[most] ? k : most;
    }
    return most;
}

static void add_tally(tally *sum, const tally *one)
{
    sum->weight += one->weight;
    sum->depth += one->depth;
    sum->coefficient += one->coefficient;
    for (int k = 0; k < 3; ++k) {
        sum->friction[k] += one->friction[k];
        sum->force[k] += one->force[k];
        sum->moment[k] += one->moment[k];
        sum->r[k] += one->r[k];
        sum->rest_normal[k] += one->rest_normal[k];
    }
    for (int k = 0; k < 6; ++k) {
        sum->curvature[k] += one->curvature[k];
    }
}

static void add_sample(const ss_sample *sample, double weight, tally *sum)
{
    const double r[3] = {(double)sample->r[0], (double)sample->r[1], (double)sample->r[2]};
    const double f[3] = {-weight * (double)sample->n[0], -weight * (double)sample->n[1],
                         -weight * (double)sample->n[2]};
    double turn[3];
    ss_cross3(turn, r, f);
    ss_add3(sum->force, sum->force, f);
    ss_add3(sum->moment, sum->moment, turn);
    ss_madd3(sum->r, sum->r, weight, r);
    sum->weight += weight;
    sum->depth += weight * (double)sample->depth;
}

static void add_friction(const ss_contact_query *query, const ss_group *group, int32_t i,
                         double stiffness, double weight, tally *sum)
{
    const ss_real *s = query->rub[group->first + i].s;
    for (int k = 0; k < 3; ++k) {
        sum->friction[k] += stiffness * (double)s[k];
    }
    sum->coefficient += weight * ss_contact_friction_coefficient(query, group->triangle);
}

/* Sums the samples up per station; the deepest one's depth. */
static double tally_samples(const ss_contact_query *query, const ss_frame *frame,
                            tally station[MAX_STATIONS])
{
    const ss_surface *surface = query->surface;
    double deepest = 0.0;
    for (int32_t g = 0; g < query->group_count; ++g) {
        const ss_group *group = &query->group[g];
        const double scale = query->stiffness * (double)surface->area[group->triangle] /
                             (surface->grid.facet_count * surface->grid.part_count);
        for (int32_t i = 0; i < group->count; ++i) {
            const ss_sample *s = &query->sample[group->first + i];
            const double depth = (double)s->depth;
            const double z = (double)(s->r[0] * frame->axis[0] + s->r[1] * frame->axis[1] +
                                      s->r[2] * frame->axis[2]);
            double share[MAX_STATIONS];
            station_shares(query, z, share);
            deepest = fmax(deepest, depth);
            for (int k = 0; k < query->station_count; ++k) {
                const double weight = scale * (double)ss_contact_query_push(query, s) * share[k];
                if (!(weight > 0.0)) {
                    continue;
                }
                add_sample(s, weight, &station[k]);
                if (query->rub != NULL) {
                    add_friction(query, group, i, scale * share[k], weight, &station[k]);
                }
                add_tissue(surface, group->triangle, s->sample_index, weight, &station[k]);
            }
        }
    }
    return deepest;
}

/* Moves `r` across the force onto its line of action, by `most` at most. */
static void shift_to_line(const tally *sum, double most, double r[3])
{
    const double square = ss_dot3(sum->force, sum->force);
    double turn[3], shift[3];
    ss_cross3(turn, r, sum->force);
    ss_sub3(turn, sum->moment, turn);
    ss_cross3(shift, sum->force, turn);
    const double length = ss_norm3(shift);
    if (length > 0.0) {
        ss_madd3(r, r, fmin(1.0 / square, most / length), shift);
    }
}

static void set_contact(const ss_contact_query *query, const ss_frame *frame,
                        const ss_tool_pose *pose, const tally *sum, ss_contact *out)
{
    double r[3], gradient[3];
    ss_real at[3];
    ss_scale3(r, sum->r, 1.0 / sum->weight);
    for (int k = 0; k < 3; ++k) {
        at[k] = (ss_real)r[k];
    }
    const double mean_depth = sum->depth / sum->weight;
    const double d = ss_frame_distance(frame, at, gradient);
    *out = (ss_contact){.force = ss_norm3(sum->force)};
    ss_copy3(out->normal, sum->force);
    /* Squeezed equally from all sides: no direction of force. */
    if (out->force > 1e-6 * sum->weight) {
        ss_normalize3(out->normal);
    } else {
        ss_scale3(out->normal, gradient, -1.0);
    }
    if (query->shape.kind == SS_SHAPE_SPHERE) {
        ss_madd3(out->point, pose->position, mean_depth - query->shape.radius, out->normal);
    } else {
        ss_madd3(r, r, -mean_depth - d, gradient);
        shift_to_line(sum, 0.25 * ss_shape_inradius(&query->shape), r);
        ss_add3(out->point, pose->position, r);
    }
    set_curvature(sum, out->normal, out->curvature);
    ss_copy3(out->friction, sum->friction);
    out->coefficient = sum->coefficient / sum->weight;
}

/* ---- not touching ---- */

typedef struct nearest {
    double distance; /* of the best so far */
    int32_t triangle, sample_index;
    double r[3], gradient[3], facet_normal[3];
} nearest;

/* Facet normal, out of the tissue. */
static void facet_normal(const ss_wide *a, const ss_wide *b, const ss_wide *c, double out[3])
{
    double first[3], second[3];
    for (int k = 0; k < 3; ++k) {
        first[k] = (double)((*b)[k] - (*a)[k]);
        second[k] = (double)((*c)[k] - (*a)[k]);
    }
    ss_cross3(out, first, second);
    ss_normalize3(out);
}

/* Signed distance of the point at `r` from the tool's origin. */
static double distance_at(const ss_frame *frame, const ss_wide *r)
{
    const ss_real at[3] = {(*r)[0], (*r)[1], (*r)[2]};
    return ss_frame_distance(frame, at, NULL);
}

static double length_of(const ss_wide *a)
{
    return sqrt((double)((*a)[0] * (*a)[0] + (*a)[1] * (*a)[1] + (*a)[2] * (*a)[2]));
}

/* Is a ball that holds the points further away than the best so far? */
static bool is_further(const ss_frame *frame, const ss_wide *const *point, int count,
                       const nearest *best)
{
    ss_wide middle = {0};
    double radius = 0.0;
    for (int k = 0; k < count; ++k) {
        middle += *point[k];
    }
    middle /= (ss_real)count;
    for (int k = 0; k < count; ++k) {
        const ss_wide r = *point[k] - middle;
        const double length = length_of(&r);
        radius = length > radius ? length : radius;
    }
    return !(distance_at(frame, &middle) - radius < best->distance);
}

static void search_triangle(const ss_surface *surface, const ss_frame *frame, const ss_real *u,
                            int32_t t, nearest *best)
{
    const ss_grid *grid = &surface->grid;
    const int point_count = grid->facet_count == 1 ? 3 : SS_GRID_POINTS;
    ss_wide point[SS_GRID_ROW];
    const ss_wide *all[SS_GRID_POINTS];
    ss_surface_points(surface, t, u, &frame->origin, point);
    for (int p = 0; p < SS_GRID_POINTS; ++p) {
        all[p] = &point[p];
    }
    if (is_further(frame, all, point_count, best)) {
        return;
    }
    for (int32_t f = 0; f < grid->facet_count; ++f) {
        const ss_wide *const p[3] = {&point[grid->facet[f][0]], &point[grid->facet[f][1]],
                                     &point[grid->facet[f][2]]};
        if (is_further(frame, p, 3, best)) {
            continue;
        }
        for (int32_t part = 0; part < grid->part_count; ++part) {
            ss_wide x;
            ss_grid_sample(grid, f, part, point, &x);
            const ss_real r[3] = {x[0], x[1], x[2]};
            if (ss_frame_distance(frame, r, NULL) < best->distance) {
                best->distance = ss_frame_distance(frame, r, best->gradient);
                best->triangle = t;
                best->sample_index = f * grid->part_count + part;
                ss_set3(best->r, (double)r[0], (double)r[1], (double)r[2]);
                facet_normal(p[0], p[1], p[2], best->facet_normal);
            }
        }
    }
}

/* No point of the box is nearer to the tool than this: by the box's ball to the tool itself, and
 * by the box to the tool's ball. */
static double box_bound(const ss_contact_query *query, const ss_frame *frame, const ss_box *box)
{
    const ss_wide middle = (box->low + box->high) / 2 - frame->origin;
    const ss_wide half = (box->high - box->low) / 2;
    double gap[3];
    for (int k = 0; k < 3; ++k) {
        const double outside = fabs((double)middle[k]) - (double)half[k];
        gap[k] = outside > 0.0 ? outside : 0.0;
    }
    const double by_box = ss_norm3(gap) - query->bounding_radius;
    const double by_tool = distance_at(frame, &middle) - length_of(&half);
    return fmax(by_box, by_tool) - query->surface->moved - query->margin;
}

static void search_tree(const ss_contact_query *query, const ss_frame *frame, const ss_real *u,
                        nearest *best)
{
    const ss_surface *surface = query->surface;
    struct {
        int32_t node;
        double bound;
    } stack[SS_TREE_STACK];
    int depth = 0;
    stack[depth].node = 0;
    stack[depth++].bound = box_bound(query, frame, &surface->box[0]);
    while (depth > 0) {
        const int32_t at = stack[--depth].node;
        if (!(stack[depth].bound < best->distance)) {
            continue;
        }
        const int32_t leaf = at - (surface->leaf_count - 1);
        if (leaf >= 0) {
            const int32_t end = ss_leaf_first_triangle(surface, leaf + 1);
            for (int32_t t = ss_leaf_first_triangle(surface, leaf); t < end; ++t) {
                search_triangle(surface, frame, u, t, best);
            }
            continue;
        }
        /* The nearer child first. */
        const double left = box_bound(query, frame, &surface->box[2 * at + 1]);
        const double right = box_bound(query, frame, &surface->box[2 * at + 2]);
        const int nearer = left <= right ? 1 : 2;
        stack[depth].node = 2 * at + 3 - nearer;
        stack[depth++].bound = fmax(left, right);
        stack[depth].node = 2 * at + nearer;
        stack[depth++].bound = fmin(left, right);
    }
}

static void set_near(const ss_contact_query *query, const ss_real *u, const ss_tool_pose *pose,
                     const ss_frame *frame, double near, ss_contact_set *out_set)
{
    nearest best = {.distance = near, .triangle = -1};
    out_set->depth = -near;
    search_tree(query, frame, u, &best);
    if (best.triangle < 0) {
        return;
    }
    ss_contact *contact = &out_set->contact[0];
    tally sum = {.weight = 1.0};
    out_set->count = 1;
    contact->gap = fmax(best.distance, 1e-9);
    contact->station = main_station(query, best.r[0] * (double)frame->axis[0] +
                                               best.r[1] * (double)frame->axis[1] +
                                               best.r[2] * (double)frame->axis[2]);
    ss_add3(contact->point, pose->position, best.r);
    ss_scale3(contact->normal, best.gradient, -1.0);
    if (ss_dot3(best.facet_normal, contact->normal) > 0.5) {
        ss_copy3(contact->normal, best.facet_normal);
    }
    add_tissue(query->surface, best.triangle, best.sample_index, 1.0, &sum);
    set_curvature(&sum, contact->normal, contact->curvature);
    contact->coefficient = ss_contact_friction_coefficient(query, best.triangle);
    ss_copy3(out_set->point, contact->point);
    ss_copy3(out_set->normal, contact->normal);
    out_set->depth = -contact->gap;
}

/* ---- inside the tissue ---- */

/* How far a tool inside the tissue has to go to the nearest place outside. */
static double way_out(const ss_contact_query *query, const ss_real *u, const ss_tool_pose *pose,
                      const ss_frame *frame)
{
    nearest best = {.distance = INFINITY, .triangle = -1};
    search_tree(query, frame, u, &best);
    double inward[3], support[3];
    ss_rotate_back(inward, pose->orientation, best.r);
    ss_scale3(inward, inward, -1.0);
    ss_normalize3(inward);
    ss_shape_support(&query->shape, inward, support);
    return ss_norm3(best.r) + ss_dot3(support, inward);
}

static void set_contacts(const ss_contact_query *query, const ss_real *u, const ss_tool_pose *pose,
                         const ss_frame *frame, double near, ss_contact_set *out_set)
{
    tally station[MAX_STATIONS];
    tally whole = {.weight = 0.0};
    memset(station, 0, sizeof station);
    const double deepest = tally_samples(query, frame, station);
    for (int k = 0; k < query->station_count; ++k) {
        add_tally(&whole, &station[k]);
    }
    if (!(whole.weight > 0.0)) {
        if (near > 0.0 && isfinite(near)) {
            set_near(query, u, pose, frame, near, out_set);
        }
        return;
    }
    for (int k = 0; k < query->station_count; ++k) {
        if (station[k].weight > 1e-9 * whole.weight) {
            ss_contact *contact = &out_set->contact[out_set->count++];
            set_contact(query, frame, pose, &station[k], contact);
            contact->station = k;
        }
    }
    ss_contact mean;
    set_contact(query, frame, pose, &whole, &mean);
    ss_copy3(out_set->point, mean.point);
    ss_copy3(out_set->normal, mean.normal);
    ss_copy3(out_set->force, whole.force);
    ss_copy3(out_set->torque, whole.moment);
    out_set->depth = deepest;
}

void ss_contact_query_contacts(ss_contact_query *query, const ss_real *u, const ss_tool_pose *pose,
                               double near, ss_contact_set *out_set)
{
    *out_set = (ss_contact_set){0};
    if (!ss_is_finite(pose->position, 3) || !ss_is_finite(pose->orientation, 4)) {
        return;
    }
    ss_frame frame;
    ss_contact_query_frame(query, pose, &frame);
    set_contacts(query, u, pose, &frame, near, out_set);
    if (ss_contact_query_is_inside(query, u, pose, fmax(0.0, out_set->depth))) {
        out_set->inside_depth = way_out(query, u, pose, &frame);
    }
}
