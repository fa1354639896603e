/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/path.h"

#include <math.h>
#include <string.h>

#include "rt/vec.h"

static const double most_depth_m = 0.006, depth_share = 0.15, most_slide_m = 0.02,
                    slide_share = 0.25;
static const double press_from_m = 0.003, press_speed_m_s = 0.01, hold_s = 0.4;
static const double poke_from_m = 0.001, poke_speed_m_s[2] = {0.1, 0.3};
static const double tap_m = 0.0145, tap_hz = 4.8, tap_inside_s = 0.05;
static const double slide_speed_m_s = 0.05;
static const double rest_s = 0.2; /* before: the tool is known to the server when it comes near */
enum { POKES = 5, TAPS = 4 };

const char *ss_felt_path_name(ss_felt_path path)
{
    static const char *const name[SS_FELT_PATHS] = {"press", "poke.1", "poke.3", "tap", "slide"};
    return name[path];
}

/* ---- place ---- */

/* Where the line through `a` along unit `d` leaves the surface for the last time. */
static bool leave(const ss_mesh *mesh, const double a[3], const double d[3], double out[3])
{
    double furthest = -INFINITY;
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const double *p = mesh->position[mesh->triangle[t][0]];
        double e[3], f[3], h[3], s[3], q[3];
        ss_sub3(e, mesh->position[mesh->triangle[t][1]], p);
        ss_sub3(f, mesh->position[mesh->triangle[t][2]], p);
        ss_cross3(h, d, f);
        const double det = ss_dot3(e, h);
        if (det == 0.0) {
            continue;
        }
        ss_sub3(s, a, p);
        ss_cross3(q, s, e);
        const double u = ss_dot3(s, h) / det, v = ss_dot3(d, q) / det, at = ss_dot3(f, q) / det;
        if (u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9 && at > furthest) {
            furthest = at;
        }
    }
    ss_madd3(out, a, furthest, d);
    return isfinite(furthest);
}

/* The area's normal over what is nearer than `reach`, or the nearest triangle's. */
static void mean_normal(const ss_mesh *mesh, const double point[3], double reach, double out[3])
{
    double nearest = INFINITY, sum[3] = {0.0, 0.0, 0.0};
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *node = mesh->triangle[t];
        double n[3], middle[3], way[3];
        ss_normal3(n, mesh->position[node[0]], mesh->position[node[1]], mesh->position[node[2]]);
        ss_add3(middle, mesh->position[node[0]], mesh->position[node[1]]);
        ss_add3(middle, middle, mesh->position[node[2]]);
        ss_scale3(middle, middle, 1.0 / 3.0);
        ss_sub3(way, middle, point);
        const double distance = ss_norm3(way);
        if (distance < nearest && ss_norm3(sum) == 0.0) {
            ss_copy3(out, n);
        }
        nearest = fmin(nearest, distance);
        if (distance <= reach) {
            ss_add3(sum, sum, n);
        }
    }
    if (ss_norm3(sum) > 0.0) {
        ss_copy3(out, sum);
    }
    ss_scale3(out, out, 1.0 / ss_norm3(out));
}

/* Middle of the fixed nodes, or of the tenth of the body that lies lowest. */
static void support_middle(const ss_scene *scene, const double low[3], const double high[3],
                           double out[3])
{
    const ss_mesh *mesh = scene->mesh;
    int32_t count = 0;
    for (int pass = 0; pass < 2 && count == 0; ++pass) {
        ss_set3(out, 0.0, 0.0, 0.0);
        for (int32_t i = 0; i < mesh->node_count; ++i) {
            if (pass == 0 ? scene->fixed[i] != 0
                          : mesh->position[i][2] <= low[2] + 0.1 * (high[2] - low[2])) {
                ss_add3(out, out, mesh->position[i]);
                ++count;
            }
        }
    }
    ss_scale3(out, out, 1.0 / count);
}

/* How far the tool reaches from its origin along its own +z. */
static double tool_reach(const ss_shape *shape)
{
    double low = 0.0, high = 2.0 * ss_shape_bounding_radius(shape), normal[3];
    for (int i = 0; i < 50; ++i) {
        const double middle = 0.5 * (low + high), x[3] = {0.0, 0.0, middle};
        if (ss_shape_distance(shape, x, normal) < 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/* The shorter turn that takes z to `to`, a unit vector. */
static void turn_z_to(const double to[3], double out[4])
{
    const double w = 1.0 + to[2];
    if (w < 1e-9) {
        out[0] = out[2] = out[3] = 0.0;
        out[1] = 1.0; /* about x, half a turn */
        return;
    }
    const double size = sqrt(w * w + to[0] * to[0] + to[1] * to[1]);
    out[0] = w / size;
    out[1] = -to[1] / size;
    out[2] = to[0] / size;
    out[3] = 0.0;
}

bool ss_felt_find_place(const ss_scene *scene, ss_felt_place *out)
{
    const ss_mesh *mesh = scene->mesh;
    *out = (ss_felt_place){.probe = 0};
    while (out->probe < SOFTSIM_MAX_PROBES && !scene->tool[out->probe].is_used) {
        ++out->probe;
    }
    if (out->probe == SOFTSIM_MAX_PROBES) {
        return false;
    }
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    double middle[3] = {0.0, 0.0, 0.0}, support[3], way[3];
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            low[k] = fmin(low[k], mesh->position[i][k]);
            high[k] = fmax(high[k], mesh->position[i][k]);
            middle[k] += mesh->position[i][k] / mesh->node_count;
        }
    }
    support_middle(scene, low, high, support);
    ss_sub3(way, middle, support);
    double diagonal[3];
    ss_sub3(diagonal, high, low);
    if (ss_norm3(way) < 0.01 * ss_norm3(diagonal)) {
        ss_set3(way, 0.0, 0.0, 1.0); /* held all round: from above */
    }
    ss_scale3(way, way, 1.0 / ss_norm3(way));
    if (!leave(mesh, middle, way, out->point) && !leave(mesh, support, way, out->point)) {
        return false;
    }
    const ss_shape *shape = &scene->tool[out->probe].shape;
    mean_normal(mesh, out->point, ss_shape_bounding_radius(shape), out->normal);
    if (ss_dot3(out->normal, way) < 0.0 && !mesh->is_closed) {
        ss_scale3(out->normal, out->normal, -1.0); /* a sheet, met from its other side */
    }
    double inward[3], least = INFINITY, largest = 0.0;
    int longest = 0;
    ss_scale3(inward, out->normal, -1.0);
    turn_z_to(inward, out->orientation);
    out->reach_m = tool_reach(shape);
    for (int k = 0; k < 3; ++k) {
        const double extent = high[k] - low[k];
        least = extent > 0.0 ? fmin(least, extent) : least;
        if (extent > largest && fabs(out->normal[k]) < 0.8) {
            largest = extent;
            longest = k;
        }
    }
    out->radius_m = ss_shape_curvature_radius(shape);
    out->radius_m = out->radius_m > 0.0 ? out->radius_m : ss_shape_inradius(shape);
    out->working_force_n = scene->working_force_n;
    out->depth_m = fmin(most_depth_m, depth_share * least);
    out->slide_m = fmin(most_slide_m, slide_share * largest);
    out->along[longest] = 1.0;
    ss_madd3(out->along, out->along, -out->normal[longest], out->normal);
    ss_scale3(out->along, out->along, 1.0 / ss_norm3(out->along));
    return true;
}

/* ---- paths ---- */

/* From 0 to 1 in `seconds`, at rest at both ends. */
static double eased(double time_s, double seconds)
{
    return time_s <= 0.0 ? 0.0 : time_s >= seconds ? 1.0 : 0.5 - 0.5 * cos(M_PI * time_s / seconds);
}

static double poke_hz(const ss_felt_place *place, ss_felt_path path)
{
    const double half = 0.5 * (place->depth_m + poke_from_m);
    return poke_speed_m_s[path == SS_FELT_POKE_3] / (2.0 * M_PI * half);
}

static double press_seconds(double depth_m)
{
    return (depth_m + press_from_m) / press_speed_m_s;
}

double ss_felt_path_seconds(const ss_felt_place *place, ss_felt_path path, double *out_hold_end_s)
{
    double seconds = 0.0;
    *out_hold_end_s = NAN;
    switch (path) {
    case SS_FELT_PRESS:
        seconds = rest_s + press_seconds(place->depth_m) + hold_s;
        *out_hold_end_s = seconds;
        return seconds + press_seconds(place->depth_m);
    case SS_FELT_POKE_1:
    case SS_FELT_POKE_3:
        return rest_s + POKES / poke_hz(place, path);
    case SS_FELT_TAP:
        return rest_s + TAPS / tap_hz;
    default:
        return rest_s + 2.0 * press_seconds(0.5 * place->depth_m) +
               2.0 * place->slide_m / slide_speed_m_s;
    }
}

void ss_felt_path_last(const ss_felt_place *place, ss_felt_path path, double *out_from_s,
                       double *out_seconds)
{
    const bool is_tap = path == SS_FELT_TAP;
    *out_seconds = 1.0 / (is_tap ? tap_hz : poke_hz(place, path));
    *out_from_s = rest_s + ((is_tap ? TAPS : POKES) - 1) * *out_seconds;
}

void ss_felt_path_deep(const ss_felt_place *place, double depth_m, double out_position[3])
{
    ss_madd3(out_position, place->point, place->reach_m - depth_m, place->normal);
}

void ss_felt_path_at(const ss_felt_place *place, ss_felt_path path, bool is_held, double time_s,
                     double out_position[3])
{
    double s = 0.0, t = 0.0;
    time_s = fmax(0.0, time_s - rest_s);
    if (path == SS_FELT_PRESS) {
        const double down = press_seconds(place->depth_m);
        const double up = is_held ? 0.0 : eased(time_s - down - hold_s, down);
        s = (eased(time_s, down) - up) * (place->depth_m + press_from_m) - press_from_m;
    } else if (path == SS_FELT_POKE_1 || path == SS_FELT_POKE_3) {
        const double turns = fmin(time_s * poke_hz(place, path), POKES);
        s = 0.5 * (place->depth_m + poke_from_m) * (1.0 - cos(2.0 * M_PI * turns)) - poke_from_m;
    } else if (path == SS_FELT_TAP) {
        const double w = 2.0 * M_PI * tap_hz;
        s = -tap_m * cos(w * time_s) - tap_m * cos(0.5 * w * tap_inside_s);
    } else {
        const double depth_m = 0.5 * place->depth_m, down = press_seconds(depth_m);
        const double there = place->slide_m / slide_speed_m_s;
        const double gone = time_s - down;
        s = (eased(time_s, down) - eased(gone - 2.0 * there, down)) * (depth_m + press_from_m) -
            press_from_m;
        t = gone <= 0.0           ? 0.0
            : gone <= there       ? gone
            : gone <= 2.0 * there ? 2.0 * there - gone
                                  : 0.0;
        t *= slide_speed_m_s;
    }
    ss_madd3(out_position, place->point, place->reach_m - s, place->normal);
    ss_madd3(out_position, out_position, t, place->along);
}
