/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * One tool on the surface: source weights, penalty, linearisation.
 *
 *   weights  w_i = sum_s A_s b_si phi(d_s),  phi = (1 - d/delta)+^2,
 *            f_s = -A_s phi'(d_s) (sum_i b_si mu_i) n_s,  phi' = -2 (1 - d/delta)+ / delta
 *   penalty  U = kc sum_q A_q int_0^D_q c,  f_q = -A_q kc c(D_q) grad D_q on the nodes by B_qi,
 *            D the smooth depth in the tool (shape.c), c(D) = D + 9 (D - 0.3 r)+, r its inradius
 *   tool     force -sum f, torque -sum r x f, r from the tool's origin
 *
 * Why c: flat tissue penetrated to depth d by a sphere of radius R exerts pi kc (R - d) d^2, at
 * most 0.47 kc R^3 (at d = 2/3 R); stretched tissue, having fewer samples, exerts less. A larger
 * force drives the tool through the surface; the samples then push it onward. With c the most is
 * 1.9 kc R^3, and the tool is held where it was lost (blocks of 11 mm edges under R = 8 mm: hybrid
 * at 2.5 N, mass-spring at a speed of 3 m/s); contact that is less deep is as it was.
 * Rejected: to remember each sample's side, which is no potential, and gives energy where it turns
 * a sample back.
 *
 * The tangent, which models tell the hand's stiffness from, takes in place of c' what has no steps:
 *   c~'(D) = ramp(D) + 9 ramp(D - 0.3 r),  ramp(x) = min(1, x+ / (0.05 max_q D_q)).
 * With c' the stiffness had two values where a sample at the rim just touches and just does not;
 * the coupling's spring follows it (haptic/yield.c), and with the tool pressed that sample in or
 * let it go again: a cycle of 0.3 % of the force for ever under a hand that stood still, and no
 * body slept. Under a sphere c~' is 2.5 % less than c', in series with the tissue less than that,
 * under a face that touches all at once nothing. corotational's Newton steps have it as K_contact,
 * ten times too soft just beyond 0.3 r: more of its iterations, the same balance. The diagonal, of
 * the step bound, has c'. Rejected:
 * a spring that does not follow the last per cent (what is held then depends on how it was come
 * by), and c itself without a corner (first touches softer).
 *
 * All are functions of node positions and pose alone; what the broad phase leaves out has d > 0 (or
 * > delta), contributes exactly nothing, and the rest is summed in the surface's fixed order: the
 * bits do not depend on the broad phase's radius nor on what is culled. Two culls, both rigorous:
 * the distance is 1-Lipschitz, and since rows are convex no sample moves further than M, the
 * largest motion of a node in reach since the broad phase. So a triangle whose ball at the broad
 * phase (centre c, radius r) has d(c) > r + M holds no active sample; a facet the same with its
 * radius + 2 M.
 */
#include "contact/internal.h"

#include <math.h>
#include <string.h>

#include "contact/shape.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* ---- create ---- */

/* How many of something of area `area` each can be within the tool at once, generously. */
static int32_t capacity_for(double radius, double area, int64_t total)
{
    const double estimate = 8.0 * 4.0 * SS_PI * radius * radius / area;
    const double bounded = fmin(fmax(estimate, 4096.0), 1048576.0);
    return (int32_t)fmin(bounded, (double)total);
}

static bool allocate(ss_contact_query *query)
{
    const ss_surface *surface = query->surface;
    const size_t triangle_count = (size_t)surface->triangle_count;
    const size_t node_count = (size_t)surface->node_count;
    double area = 0.0;
    for (int32_t t = 0; t < surface->triangle_count; ++t) {
        area += (double)surface->area[t];
    }
    area = fmax(area / surface->triangle_count, 1e-30);
    const int64_t sample_total = ss_surface_sample_count(surface);
    query->sample_capacity =
        capacity_for(query->bounding_radius, area * surface->triangle_count / (double)sample_total,
                     sample_total);
    query->source_capacity =
        capacity_for(query->bounding_radius + query->delta, area, surface->triangle_count);
    query->candidate = ss_memory_get(triangle_count, sizeof(ss_candidate));
    query->candidate_node = ss_memory_get(node_count, sizeof(int32_t));
    query->candidate_u = ss_memory_get(node_count, 4 * sizeof(ss_real));
    query->mark = ss_memory_get(node_count / 64 + 1, sizeof(uint64_t));
    query->node_weight = ss_memory_get(node_count, sizeof(double));
    query->node_slot = ss_memory_get(node_count, sizeof(int32_t));
    query->weight_node = ss_memory_get(node_count, sizeof(int32_t));
    query->weight = ss_memory_get(node_count, sizeof(double));
    query->source = ss_memory_get((size_t)query->source_capacity, sizeof(ss_source));
    query->sample = ss_memory_get((size_t)query->sample_capacity, sizeof(ss_sample));
    query->group = ss_memory_get(triangle_count, sizeof(ss_group));
    return query->candidate != NULL && query->candidate_node != NULL &&
           query->candidate_u != NULL && query->mark != NULL && query->node_weight != NULL &&
           query->node_slot != NULL && query->weight_node != NULL && query->weight != NULL &&
           query->source != NULL && query->sample != NULL && query->group != NULL;
}

softsim_status ss_contact_query_create(const ss_surface *surface, const ss_shape *shape,
                                       const ss_contact_query_options *options,
                                       ss_contact_query **out_query)
{
    *out_query = NULL;
    const double radius = ss_shape_bounding_radius(shape);
    if (!(options->delta > 0.0 && isfinite(options->delta) && options->stiffness >= 0.0 &&
          isfinite(options->stiffness) && radius > 0.0 && isfinite(radius))) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    ss_contact_query *query = ss_memory_get(1, sizeof(ss_contact_query));
    if (query == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    query->surface = surface;
    query->shape = *shape;
    query->delta = options->delta;
    query->stiffness = options->stiffness;
    query->node_slack = 0.25 * options->delta;
    query->path_slack = 0.25 * options->delta;
    query->bounding_radius = radius;
    if (shape->kind == SS_SHAPE_CONVEX) {
        ss_convex_centre(shape->convex, query->centre);
    }
    double normal[3];
    query->centre_depth = -ss_shape_distance(shape, query->centre, normal);
    query->stiffening_depth =
        (ss_real)(SS_CONTACT_QUERY_STIFFENING_FROM * ss_shape_inradius(shape));
    query->margin = (sizeof(ss_real) == 4 ? 1e-5 : 1e-12) * (surface->size + radius);
    double low, high;
    ss_shape_span(shape, &low, &high);
    const double spacing = 0.5 * ss_shape_inradius(shape);
    query->station_low = low;
    query->station_high = high;
    query->station_count = high - low < spacing ? 1 : high - low < 2.0 * spacing ? 2 : 4;
    if (!allocate(query)) {
        ss_contact_query_destroy(&query);
        return SOFTSIM_ERROR_MEMORY;
    }
    *out_query = query;
    return SOFTSIM_OK;
}

void ss_contact_query_destroy(ss_contact_query **query)
{
    if (query == NULL || *query == NULL) {
        return;
    }
    ss_contact_query *t = *query;
    ss_contact_friction_destroy(t);
    void *memory[] = {t->candidate,   t->candidate_node, t->candidate_u, t->mark,
                      t->node_weight, t->node_slot,      t->weight_node, t->weight,
                      t->source,      t->sample,         t->group};
    for (size_t i = 0; i < sizeof memory / sizeof memory[0]; ++i) {
        ss_memory_free(memory[i]);
    }
    ss_memory_free(t);
    *query = NULL;
}

void ss_contact_query_set_stiffness(ss_contact_query *query, double stiffness_n_per_m3)
{
    query->stiffness = stiffness_n_per_m3;
}

/* ---- source weights ---- */

/* Weights of the corners at weight sample s: corner samples 0..2 at (2/3, 1/6, 1/6), the middle. */
static inline void weight_row(int s, ss_real out[3])
{
    for (int k = 0; k < 3; ++k) {
        out[k] = s == 3 ? (ss_real)1 / 3 : k == s ? (ss_real)2 / 3 : (ss_real)1 / 6;
    }
}

/* Adds the weights of one triangle; keeps it when it has any. */
static void weigh_triangle(ss_contact_query *query, const ss_frame *frame, const ss_real *u,
                           int32_t t, ss_mark_range *range)
{
    const ss_surface *surface = query->surface;
    const int32_t *corner = surface->control + surface->control_first[t];
    const int count = surface->grid.weight_count;
    const double area = (double)surface->area[t] / count;
    ss_source *source = &query->source[query->source_count];
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
        if (!ss_frame_find(frame, &r, (ss_real)query->delta, &d, source->n[s])) {
            continue;
        }
        const double g = 1.0 - (double)d / query->delta;
        source->slope[s] = (ss_real)(2.0 * area * g / query->delta);
        for (int k = 0; k < 3; ++k) {
            source->r[s][k] = r[k];
            share[k] += area * g * g * (double)row[k];
        }
    }
    if (share[0] > 0.0) {
        source->triangle = t;
        query->source_count++;
        for (int k = 0; k < 3; ++k) {
            query->node_weight[corner[k]] += share[k];
            ss_contact_query_mark(query, range, corner[k]);
        }
    }
}

int32_t ss_contact_query_weigh(ss_contact_query *query, const ss_real *u, const uint8_t *is_source,
                               const ss_tool_pose *pose, const int32_t **out_node,
                               const double **out_weight, double *out_total)
{
    const ss_surface *surface = query->surface;
    ss_mark_range range = {INT32_MAX, -1};
    ss_frame frame;
    ss_contact_query_frame(query, pose, &frame);
    const ss_real extra =
        (ss_real)(query->delta + query->margin) + ss_contact_query_moved(query, u);
    query->source_count = 0;
    for (int32_t i = 0; i < query->candidate_count; ++i) {
        const ss_candidate *c = &query->candidate[i];
        if (query->source_count < query->source_capacity &&
            !ss_candidate_is_beyond(&frame, c, extra)) {
            weigh_triangle(query, &frame, u, c->triangle, &range);
        }
    }

    /* The list of nodes, and where it holds the corners of each triangle. */
    int32_t *node = query->weight_node;
    const int32_t marked = ss_contact_query_take_marked(query, &range, node);
    int32_t count = 0;
    double total = 0.0;
    for (int32_t i = 0; i < marked; ++i) {
        const bool is_used = is_source == NULL || is_source[node[i]];
        query->weight[count] = query->node_weight[node[i]];
        query->node_weight[node[i]] = 0.0;
        query->node_slot[node[i]] = is_used ? count : -1;
        if (is_used) {
            total += query->weight[count];
            node[count++] = node[i];
        }
    }
    for (int32_t i = 0; i < query->source_count; ++i) {
        ss_source *source = &query->source[i];
        const int32_t *corner = surface->control + surface->control_first[source->triangle];
        for (int k = 0; k < 3; ++k) {
            source->slot[k] = query->node_slot[corner[k]];
        }
    }
    query->weight_count = count;
    *out_node = node;
    *out_weight = query->weight;
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

void ss_contact_query_weight_forces(const ss_contact_query *query, const double *mu, ss_real *force,
                                    double tool_force[3], double tool_torque[3])
{
    const ss_surface *surface = query->surface;
    const int count = surface->grid.weight_count;
    double sum[3] = {0.0, 0.0, 0.0};
    double moment[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; i < query->source_count; ++i) {
        const ss_source *source = &query->source[i];
        const int32_t *corner = surface->control + surface->control_first[source->triangle];
        double at[3];
        double on_node[3][3] = {{0.0}};
        for (int k = 0; k < 3; ++k) {
            const int32_t slot = source->slot[k];
            at[k] = slot < 0 ? 0.0 : mu ? mu[slot] : 1.0;
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
            double f[3], r[3], turn[3];
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
        for (int k = 0; k < 3 && force; ++k) {
            for (int c = 0; c < 3; ++c) {
                force[4 * (int64_t)corner[k] + c] += (ss_real)on_node[k][c];
            }
        }
    }
    push_tool(sum, moment, tool_force, tool_torque);
}

/* ---- penalty ---- */

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
            const ss_real s = ss_wide_square(&r);
            square = s > square || isnan(s) ? s : square;
        }
    }
    return ss_real_root(square);
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
        if (ss_frame_is_beyond(frame, &middle, radius)) {
            continue;
        }
        for (int32_t part = 0; part < grid->part_count; ++part) {
            ss_wide r;
            ss_grid_sample(grid, f, part, point, &r);
            ss_sample *sample = &out[count];
            ss_real d;
            if (ss_frame_find(frame, &r, 0, &d, sample->n)) {
                sample->r[0] = r[0];
                sample->r[1] = r[1];
                sample->r[2] = r[2];
                sample->depth = -d;
                ss_frame_depth(frame, &r, &sample->depth, sample->n, &sample->lean);
                sample->sample_index = f * grid->part_count + part;
                count++;
            }
        }
    }
    return count;
}

/* Spreads samples' forces over the triangle's points and sums them up. */
static void sum_samples(const ss_contact_query *query, const ss_grid *grid, const ss_sample *sample,
                        int32_t count, ss_real scale, ss_wide value[SS_GRID_ROW], penalty_sum *sum)
{
    ss_wide force = {0};
    ss_wide moment = {0};
    ss_real squares = 0;
    for (int p = 0; p < SS_GRID_ROW; ++p) {
        value[p] = (ss_wide){0};
    }
    for (int32_t i = 0; i < count; ++i) {
        const ss_sample *s = &sample[i];
        const uint8_t *p = grid->facet[s->sample_index / grid->part_count];
        const ss_real *c = grid->part[s->sample_index % grid->part_count];
        const ss_real push = scale * ss_contact_query_push(query, s);
        const ss_wide f = {push * s->n[0], push * s->n[1], push * s->n[2], 0};
        value[p[0]] += c[0] * f;
        value[p[1]] += c[1] * f;
        value[p[2]] += c[2] * f;
        force += f;
        moment += (ss_wide){s->r[1] * f[2] - s->r[2] * f[1], s->r[2] * f[0] - s->r[0] * f[2],
                            s->r[0] * f[1] - s->r[1] * f[0], 0};
        const ss_real more = s->depth - query->stiffening_depth;
        squares +=
            s->depth * s->depth + (more > 0 ? (SS_CONTACT_QUERY_STIFFENING - 1) * more * more : 0);
    }
    for (int k = 0; k < 3; ++k) {
        sum->force[k] += (double)force[k];
        sum->moment[k] += (double)moment[k];
    }
    sum->energy += 0.5 * (double)scale * (double)squares;
}

double ss_contact_query_penalty(ss_contact_query *query, const ss_real *u, const ss_tool_pose *pose,
                                ss_real *force, double tool_force[3], double tool_torque[3])
{
    const ss_surface *surface = query->surface;
    penalty_sum sum = {{0.0}, {0.0}, 0.0};
    ss_frame frame;
    ss_contact_query_frame(query, pose, &frame);
    const ss_real moved = ss_contact_query_moved(query, u) + (ss_real)query->margin;
    const int32_t most = surface->grid.facet_count * surface->grid.part_count;
    ss_sample discarded[SS_GRID_FACETS * SS_MAX_PARTS * SS_MAX_PARTS];
    query->sample_count = 0;
    query->group_count = 0;
    query->dropped_from = query->candidate_count;
    query->max_facet_radius = 0;
    for (int32_t i = 0; i < query->candidate_count; ++i) {
        ss_candidate *candidate = &query->candidate[i];
        const int32_t t = candidate->triangle;
        if (ss_candidate_is_beyond(&frame, candidate, moved)) {
            continue;
        }
        ss_wide point[SS_GRID_ROW];
        ss_surface_points(surface, t, u, &frame.origin, point);
        if (!(candidate->facet_radius >= 0)) {
            candidate->facet_radius = facet_radius(&surface->grid, point) + 2 * moved;
        }
        const ss_real facet_reach = candidate->facet_radius + 2 * moved;
        query->max_facet_radius =
            facet_reach > query->max_facet_radius ? facet_reach : query->max_facet_radius;
        const bool is_kept = query->sample_count + most <= query->sample_capacity &&
                             query->dropped_from == query->candidate_count;
        ss_sample *sample = is_kept ? query->sample + query->sample_count : discarded;
        const int32_t count = find_samples(surface, &frame, point, facet_reach, sample);
        if (count == 0) {
            continue;
        }
        ss_wide value[SS_GRID_ROW];
        sum_samples(query, &surface->grid, sample, count, ss_contact_query_scale(query, t), value,
                    &sum);
        if (force != NULL) {
            ss_surface_scatter(surface, t, value, force);
        }
        if (is_kept) {
            query->group[query->group_count++] = (ss_group){t, query->sample_count, count};
            query->sample_count += count;
        } else if (query->dropped_from == query->candidate_count) {
            query->dropped_from = i;
        }
    }
    push_tool(sum.force, sum.moment, tool_force, tool_torque);
    return sum.energy;
}

/* ---- linearisation ---- */

/* The depth over which a sample comes to count, m. */
static ss_real rise_depth(const ss_contact_query *query)
{
    ss_real deepest = 0;
    for (int32_t i = 0; i < query->sample_count; ++i) {
        const ss_real depth = query->sample[i].depth;
        deepest = depth > deepest ? depth : deepest;
    }
    return (ss_real)SS_CONTACT_QUERY_RISE * deepest;
}

/* 0 at `depth` 0, 1 from `rise` on; with `rise` 0 the step itself. */
static inline ss_real risen(ss_real depth, ss_real rise)
{
    return depth < rise ? (depth > 0 ? depth / rise : 0) : 1;
}

/* c~'(D) |grad D|^2, along the sample's normal; with `rise` 0 c' in place of c~'. */
static inline ss_real slope_of(const ss_contact_query *query, const ss_sample *sample, ss_real rise)
{
    const ss_real more = risen(sample->depth - query->stiffening_depth, rise);
    return sample->lean * sample->lean *
           (risen(sample->depth, rise) + (SS_CONTACT_QUERY_STIFFENING - 1) * more);
}

/* The friction's part of it: less its stiffness times the motions along the surface. */
static void add_hold(const ss_contact_query *query, const ss_group *group, ss_real scale,
                     ss_real rise, const ss_wide move[SS_GRID_ROW], const ss_wide *shift,
                     ss_wide value[SS_GRID_ROW], ss_wide *on_tool)
{
    const ss_grid *grid = &query->surface->grid;
    for (int32_t i = group->first; i < group->first + group->count; ++i) {
        const ss_sample *s = &query->sample[i];
        const uint8_t *p = grid->facet[s->sample_index / grid->part_count];
        const ss_real *c = grid->part[s->sample_index % grid->part_count];
        const ss_wide m = c[0] * move[p[0]] + c[1] * move[p[1]] + c[2] * move[p[2]] - *shift;
        const ss_real along = s->n[0] * m[0] + s->n[1] * m[1] + s->n[2] * m[2];
        const ss_real hold = scale * query->rub[i].hold * risen(s->depth, rise);
        const ss_wide f = {hold * (along * s->n[0] - m[0]), hold * (along * s->n[1] - m[1]),
                           hold * (along * s->n[2] - m[2]), 0};
        value[p[0]] += c[0] * f;
        value[p[1]] += c[1] * f;
        value[p[2]] += c[2] * f;
        *on_tool += f;
    }
}

void ss_contact_query_tangent(const ss_contact_query *query, const ss_real *du, const double dx[3],
                              ss_real *dforce, double dtool[3])
{
    const ss_surface *surface = query->surface;
    const ss_grid *grid = &surface->grid;
    const ss_wide shift = {(ss_real)dx[0], (ss_real)dx[1], (ss_real)dx[2], 0};
    const ss_real rise = rise_depth(query);
    double sum[3] = {0.0, 0.0, 0.0};
    for (int32_t g = 0; g < query->group_count; ++g) {
        const ss_group *group = &query->group[g];
        const ss_real scale = ss_contact_query_scale(query, group->triangle);
        ss_wide move[SS_GRID_ROW], value[SS_GRID_ROW];
        ss_wide on_tool = {0};
        for (int p = 0; p < SS_GRID_ROW; ++p) {
            move[p] = (ss_wide){0};
            value[p] = (ss_wide){0};
        }
        if (du != NULL) {
            ss_surface_moves(surface, group->triangle, du, move);
        }
        for (int32_t i = 0; i < group->count; ++i) {
            const ss_sample *s = &query->sample[group->first + i];
            const uint8_t *p = grid->facet[s->sample_index / grid->part_count];
            const ss_real *c = grid->part[s->sample_index % grid->part_count];
            const ss_wide m = c[0] * move[p[0]] + c[1] * move[p[1]] + c[2] * move[p[2]] - shift;
            const ss_real push = -scale * slope_of(query, s, rise) *
                                 (s->n[0] * m[0] + s->n[1] * m[1] + s->n[2] * m[2]);
            const ss_wide f = {push * s->n[0], push * s->n[1], push * s->n[2], 0};
            value[p[0]] += c[0] * f;
            value[p[1]] += c[1] * f;
            value[p[2]] += c[2] * f;
            on_tool += f;
        }
        if (query->rub != NULL) {
            add_hold(query, group, scale, rise, move, &shift, value, &on_tool);
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

static void add_diagonal(const ss_contact_query *query, ss_real rise, double *diagonal)
{
    const ss_surface *surface = query->surface;
    const ss_grid *grid = &surface->grid;
    double value[SS_GRID_ROW];
    for (int32_t g = 0; g < query->group_count; ++g) {
        const ss_group *group = &query->group[g];
        const double scale = (double)ss_contact_query_scale(query, group->triangle);
        memset(value, 0, sizeof value);
        for (int32_t i = 0; i < group->count; ++i) {
            const int32_t sample_index = query->sample[group->first + i].sample_index;
            const double slope = (double)slope_of(query, &query->sample[group->first + i], rise);
            for (int k = 0; k < 3; ++k) {
                value[grid->facet[sample_index / grid->part_count][k]] +=
                    scale * slope * (double)grid->part[sample_index % grid->part_count][k];
            }
        }
        scatter_scalar(surface, group->triangle, value, diagonal);
    }
    /* Triangles whose samples were not kept count as wholly inside: the step bound stays safe. */
    for (int32_t i = query->dropped_from; i < query->candidate_count; ++i) {
        const int32_t t = query->candidate[i].triangle;
        memset(value, 0, sizeof value);
        for (int32_t f = 0; f < grid->facet_count; ++f) {
            for (int k = 0; k < 3; ++k) {
                value[grid->facet[f][k]] += SS_CONTACT_QUERY_STIFFENING * query->stiffness *
                                            (double)surface->area[t] / (3.0 * grid->facet_count);
            }
        }
        scatter_scalar(surface, t, value, diagonal);
    }
}

void ss_contact_query_diagonal(const ss_contact_query *query, double *diagonal)
{
    add_diagonal(query, 0, diagonal);
}

void ss_contact_query_tangent_diagonal(const ss_contact_query *query, double *diagonal)
{
    add_diagonal(query, rise_depth(query), diagonal);
}
