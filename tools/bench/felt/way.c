/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/way.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/vec.h"

static const double half_m = 0.025, march_m = 0.25e-3, least_m = 0.002;
static const double most_turn_cosine = 0.7071;
static const double edges_per_wave = 2.5;
enum { MOST_DEGREE_OF_WAY = 6, MOST_DEGREE_OF_FORCE = 16, LEAST_DEGREE = 2, MARCH = 100 };
enum { AROUND = 5 }; /* milliseconds */

/* ---- polynomials ---- */

int32_t ss_way_degree(double length_m, double edge_m, int32_t most)
{
    /* A polynomial of degree p has p / 2 waves. */
    const double degree = floor(2.0 * length_m / (edges_per_wave * edge_m));
    return degree < LEAST_DEGREE ? LEAST_DEGREE : degree > most ? most : (int32_t)degree;
}

/* By polynomials that are orthogonal on the points (Forsythe 1957):
 * p_(k+1) = (x - a_k) p_k - b_k p_(k-1). */
bool ss_way_fit(int32_t count, const double *at, int32_t degree, const double (*value)[3],
                double (*out)[3])
{
    double *memory = calloc(3 * (size_t)count + 1, sizeof *memory);
    if (memory == NULL) {
        return false;
    }
    double *x = memory, *p = x + count, *last = p + count, last_square = 1.0;
    const double middle = 0.5 * (at[0] + at[count - 1]);
    const double half = 0.5 * fabs(at[count - 1] - at[0]);
    for (int32_t i = 0; i < count; ++i) {
        x[i] = half > 0.0 ? (at[i] - middle) / half : 0.0;
        p[i] = 1.0;
        ss_set3(out[i], 0.0, 0.0, 0.0);
    }
    for (int32_t k = 0; k <= degree && k < count; ++k) {
        double square = 0.0, moment = 0.0, share[3] = {0.0, 0.0, 0.0};
        for (int32_t i = 0; i < count; ++i) {
            square += p[i] * p[i];
            moment += x[i] * p[i] * p[i];
            ss_madd3(share, share, p[i], value[i]);
        }
        for (int32_t i = 0; i < count; ++i) {
            ss_madd3(out[i], out[i], p[i] / square, share);
            const double next =
                (x[i] - moment / square) * p[i] - (k > 0 ? square / last_square * last[i] : 0.0);
            last[i] = p[i];
            p[i] = next;
        }
        last_square = square;
    }
    free(memory);
    return true;
}

/* ---- the way ---- */

/* The surface's point nearest to `p`. */
static void nearest_point(const ss_mesh *mesh, const double p[3], double out[3])
{
    double nearest = INFINITY;
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *node = mesh->triangle[t];
        double q[3], way[3];
        ss_contact_closest(p, mesh->position[node[0]], mesh->position[node[1]],
                           mesh->position[node[2]], q);
        ss_sub3(way, q, p);
        if (ss_norm3(way) < nearest) {
            nearest = ss_norm3(way);
            ss_copy3(out, q);
        }
    }
}

/* Triangles' normals about `point`, on the side of `facing`, by area and exp(-(distance/reach)^2):
 * smooth along a way. */
static void smooth_normal(const ss_mesh *mesh, const double point[3], double reach,
                          const double facing[3], double out[3])
{
    double sum[3] = {0.0, 0.0, 0.0};
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *node = mesh->triangle[t];
        double n[3], middle[3];
        ss_normal3(n, mesh->position[node[0]], mesh->position[node[1]], mesh->position[node[2]]);
        for (int k = 0; k < 3; ++k) {
            middle[k] = (mesh->position[node[0]][k] + mesh->position[node[1]][k] +
                         mesh->position[node[2]][k]) /
                            3.0 -
                        point[k];
        }
        if (ss_dot3(n, facing) > 0.0) {
            ss_madd3(sum, sum, exp(-ss_dot3(middle, middle) / (reach * reach)), n);
        }
    }
    ss_copy3(out, ss_norm3(sum) > 0.0 ? sum : facing);
    (void)ss_normalize3(out);
}

/* Mean edge of the triangles whose middle is within `reach` of `point`, of all where none is. */
static double near_edge(const ss_mesh *mesh, const double point[3], double reach)
{
    double sum[2] = {0.0, 0.0};
    int64_t count[2] = {0, 0};
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        double middle[3] = {0.0, 0.0, 0.0}, edges = 0.0, way[3];
        for (int k = 0; k < 3; ++k) {
            const double *a = mesh->position[mesh->triangle[t][k]];
            ss_sub3(way, mesh->position[mesh->triangle[t][(k + 1) % 3]], a);
            edges += ss_norm3(way);
            ss_madd3(middle, middle, 1.0 / 3.0, a);
        }
        ss_sub3(way, middle, point);
        const int is_near = ss_norm3(way) <= reach;
        sum[is_near] += edges;
        count[is_near] += 3;
    }
    return count[1] > 0 ? sum[1] / (double)count[1] : sum[0] / (double)count[0];
}

static bool is_held_near(const ss_scene *scene, const double point[3], double reach)
{
    for (int32_t i = 0; i < scene->mesh->node_count; ++i) {
        double way[3];
        ss_sub3(way, scene->mesh->position[i], point);
        if (scene->fixed[i] != 0 && ss_norm3(way) < reach) {
            return true;
        }
    }
    return false;
}

typedef struct marcher {
    const ss_scene *scene;
    const ss_felt_place *place;
    double across[3]; /* of the way's plane */
    double reach;     /* m, of the tool */
} marcher;

/* Walks from the place towards `sign` of the way; points of the tool's origin into out[], the
 * place's first. Returns their number. */
static int32_t march(const marcher *m, double sign, double (*out)[3])
{
    double x[3], n[3], t[3], ahead[3];
    ss_copy3(x, m->place->point);
    smooth_normal(m->scene->mesh, x, m->reach, m->place->normal, n);
    for (int32_t k = 0;; ++k) {
        ss_madd3(out[k], x, m->place->reach_m - 0.5 * m->place->depth_m, n);
        if (k == MARCH) {
            return k + 1;
        }
        ss_cross3(t, m->across, n);
        (void)ss_normalize3(t);
        ss_madd3(ahead, x, sign * march_m, t);
        nearest_point(m->scene->mesh, ahead, x);
        double drift[3];
        ss_sub3(drift, ahead, x);
        smooth_normal(m->scene->mesh, x, m->reach, n, n);
        const bool is_end = ss_norm3(drift) > 0.5 * march_m; /* past a rim, or round a corner */
        if (is_end || ss_dot3(n, m->place->normal) < most_turn_cosine ||
            is_held_near(m->scene, x, 1.5 * m->reach)) {
            return k + 1;
        }
    }
}

/* The marched points as an even polynomial way. */
static bool smooth_way(int32_t count, const double (*point)[3], ss_way *out)
{
    double at[2 * MARCH + 1], fit[2 * MARCH + 1][3], way[3];
    at[0] = 0.0;
    for (int32_t k = 1; k < count; ++k) {
        ss_sub3(way, point[k], point[k - 1]);
        at[k] = at[k - 1] + ss_norm3(way);
    }
    const int32_t degree = ss_way_degree(at[count - 1], out->edge_m, MOST_DEGREE_OF_WAY);
    if (!ss_way_fit(count, at, degree, point, fit)) {
        return false;
    }
    for (int32_t k = 1; k < count; ++k) {
        ss_sub3(way, fit[k], fit[k - 1]);
        at[k] = at[k - 1] + ss_norm3(way);
    }
    out->length_m = at[count - 1];
    const ss_way_pass pass = {count, at, (const double(*)[3])fit};
    for (int32_t k = 0; k < SS_WAY_POINTS; ++k) {
        ss_way_force(&pass, out->length_m * k / (SS_WAY_POINTS - 1), out->point[k]);
    }
    return true;
}

bool ss_way_find(const ss_scene *scene, const ss_felt_place *place, int32_t direction, ss_way *out)
{
    const double angle = direction * M_PI / SS_WAY_DIRECTIONS;
    double side[3], along[3], point[2 * MARCH + 1][3], back[MARCH + 1][3], ahead[MARCH + 1][3];
    marcher m = {.scene = scene,
                 .place = place,
                 .reach = ss_shape_bounding_radius(&scene->tool[place->probe].shape)};
    ss_cross3(side, place->normal, place->along);
    ss_scale3(along, place->along, cos(angle));
    ss_madd3(along, along, sin(angle), side);
    ss_cross3(m.across, place->normal, along);
    const int32_t behind = march(&m, -1.0, back) - 1, before = march(&m, 1.0, ahead);
    const int32_t count = behind + before;
    for (int32_t k = 0; k < behind; ++k) {
        ss_copy3(point[k], back[behind - k]);
    }
    memcpy(point[behind], ahead, (size_t)before * sizeof *ahead);
    *out = (ss_way){.edge_m = near_edge(scene->mesh, place->point, half_m)};
    if ((count - 1) * march_m < least_m || !smooth_way(count, (const double(*)[3])point, out)) {
        return false;
    }
    double from[3];
    nearest_point(scene->mesh, out->point[0], from);
    smooth_normal(scene->mesh, from, m.reach, place->normal, out->normal);
    return true;
}

void ss_way_at(const ss_way *way, double way_m, double out_position[3])
{
    const double at = fmin(fmax(way_m / way->length_m, 0.0), 1.0) * (SS_WAY_POINTS - 1);
    const int32_t k = at < SS_WAY_POINTS - 2 ? (int32_t)at : SS_WAY_POINTS - 2;
    ss_scale3(out_position, way->point[k], k + 1 - at);
    ss_madd3(out_position, out_position, at - k, way->point[k + 1]);
}

/* ---- figures ---- */

void ss_way_force(const ss_way_pass *pass, double way_m, double out[3])
{
    const bool is_up = pass->way_m[pass->count - 1] >= pass->way_m[0];
    int32_t low = 0, high = pass->count - 1;
    while (high - low > 1) {
        const int32_t k = (low + high) / 2;
        const bool is_beyond = is_up ? pass->way_m[k] > way_m : pass->way_m[k] < way_m;
        *(is_beyond ? &high : &low) = k;
    }
    const double span = pass->way_m[high] - pass->way_m[low];
    const double share = span != 0.0 ? (way_m - pass->way_m[low]) / span : 0.0;
    ss_scale3(out, pass->force[low], 1.0 - share);
    ss_madd3(out, out, share, pass->force[high]);
}

/* The change from millisecond k - 1 to k, less the mean change of those around it. */
static double jump_at(const ss_way_pass *pass, int32_t k)
{
    const int32_t from = k - 1 > AROUND ? k - 1 - AROUND : 0;
    const int32_t end = k + AROUND < pass->count - 1 ? k + AROUND : pass->count - 1;
    double own[3], mean[3];
    ss_sub3(own, pass->force[k], pass->force[k - 1]);
    ss_sub3(mean, pass->force[end], pass->force[from]);
    ss_madd3(own, own, -1.0 / (end - from), mean);
    return ss_norm3(own);
}

/* Adds a pass to the sums of squares and the largest. */
static bool judge_pass(const ss_way_pass *pass, double edge_m, double *square, ss_way_figures *out)
{
    double(*trend)[3] = calloc((size_t)pass->count + 1, sizeof *trend);
    const double length = fabs(pass->way_m[pass->count - 1] - pass->way_m[0]);
    const int32_t degree = ss_way_degree(length, edge_m, MOST_DEGREE_OF_FORCE);
    if (trend == NULL || !ss_way_fit(pass->count, pass->way_m, degree, pass->force, trend)) {
        free(trend);
        return false;
    }
    for (int32_t k = 0; k < pass->count; ++k) {
        double apart[3], turn[3];
        ss_sub3(apart, pass->force[k], trend[k]);
        ss_cross3(turn, pass->force[k], trend[k]);
        *square += ss_dot3(apart, apart) / pass->count;
        out->tilt = fmax(out->tilt, atan2(ss_norm3(turn), ss_dot3(pass->force[k], trend[k])));
        if (k > 0) {
            ss_sub3(apart, pass->force[k], pass->force[k - 1]);
            out->step = fmax(out->step, ss_norm3(apart));
            out->jump = fmax(out->jump, jump_at(pass, k));
        }
        out->mean_n += ss_norm3(pass->force[k]) / pass->count;
    }
    free(trend);
    return true;
}

bool ss_way_judge(const ss_way_pass *forward, const ss_way_pass *back, double edge_m,
                  ss_way_figures *out)
{
    double square = 0.0;
    *out = (ss_way_figures){.mean_n = 0.0};
    if (!judge_pass(forward, edge_m, &square, out) || !judge_pass(back, edge_m, &square, out)) {
        return false;
    }
    for (int32_t k = 0; k < forward->count; ++k) {
        double apart[3];
        ss_way_force(back, forward->way_m[k], apart);
        ss_sub3(apart, apart, forward->force[k]);
        out->loop = fmax(out->loop, ss_norm3(apart));
    }
    out->mean_n *= 0.5;
    const double share = out->mean_n > 0.0 ? 1.0 / out->mean_n : (double)NAN;
    out->step *= share;
    out->jump *= share;
    out->ripple = sqrt(2.0 * 0.5 * square) * share;
    out->tilt = out->mean_n > 0.0 ? out->tilt : (double)NAN;
    out->loop *= share;
    return true;
}
