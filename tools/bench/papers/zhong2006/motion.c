/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/papers/zhong2006/motion.h"
/*
 * (5), (6): the strain is linear, eps = (grad u + grad u^T)/2, of the plane triangles around the
 * contact, weighted by their areas at rest. On a surface grad u is known along the surface only:
 * with t1, t2 in the triangle and n its normal, eps has in-plane parts and, of du/dt1 and du/dt2
 * along n, transverse shear; eps_nn is 0. A point pushed straight in has nothing but that shear.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/each.h"
#include "rt/vec.h"

bool ss_zhong_hooke(double along, double across, double out_tensor[6][6])
{
    static const double ratio = 0.3;
    const double young[3] = {along, across, across};
    double compliance[9];
    double identity[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    memset(out_tensor, 0, 36 * sizeof(double));
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const double stiffer = fmax(young[i], young[j]);
            compliance[3 * i + j] = i == j ? 1.0 / young[i] : -ratio / stiffer;
        }
        const double a = young[(i + 1) % 3], b = young[(i + 2) % 3];
        out_tensor[3 + i][3 + i] = a * b / (a + b) / (1.0 + ratio);
    }
    if (!ss_zhong_cholesky(3, compliance, 3, identity)) {
        return false;
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            out_tensor[i][j] = identity[3 * i + j];
        }
    }
    return true;
}

bool ss_zhong_motion_init(ss_zhong_motion *motion, const ss_zhong_net *net, const ss_zhong_law *law,
                          int32_t contact, int32_t triangle_count, const int32_t (*triangle)[3])
{
    const size_t n = (size_t)net->node_count;
    *motion =
        (ss_zhong_motion){.net = net, .law = law, .contact = contact, .axis = {0.0, 0.0, 1.0}};
    motion->u = calloc(n, sizeof *motion->u);
    motion->v = calloc(n, sizeof *motion->v);
    motion->scratch = calloc(6 * n, sizeof *motion->scratch);
    for (int32_t t = 0; t < triangle_count && motion->triangle_count < 16; ++t) {
        if (triangle[t][0] == contact || triangle[t][1] == contact || triangle[t][2] == contact) {
            memcpy(motion->star[motion->triangle_count++], triangle[t], sizeof *triangle);
        }
    }
    return motion->u != NULL && motion->v != NULL && motion->scratch != NULL;
}

void ss_zhong_motion_fini(ss_zhong_motion *motion)
{
    SS_EACH(free, motion->u, motion->v, motion->scratch);
    *motion = (ss_zhong_motion){.net = NULL};
}

/* Strain of one triangle (xx yy zz 2yz 2zx 2xy); returns its area. */
static double triangle_strain(const ss_zhong_motion *m, const double (*u)[3],
                              const int32_t corner[3], double out_strain[6])
{
    double a[3], b[3], n[3], x[3], y[3], du[2][3];
    ss_sub3(a, m->net->rest[corner[1]], m->net->rest[corner[0]]);
    ss_sub3(b, m->net->rest[corner[2]], m->net->rest[corner[0]]);
    ss_sub3(du[0], u[corner[1]], u[corner[0]]);
    ss_sub3(du[1], u[corner[2]], u[corner[0]]);
    ss_cross3(n, a, b);
    const double area = 0.5 * ss_normalize3(n);
    ss_madd3(x, m->axis, -ss_dot3(m->axis, n), n);
    ss_normalize3(x);
    ss_cross3(y, n, x);
    /* du/dx and du/dy from the two sides. */
    const double ax = ss_dot3(a, x), ay = ss_dot3(a, y), bx = ss_dot3(b, x), by = ss_dot3(b, y);
    const double determinant = ax * by - ay * bx;
    double gradient[2][3];
    for (int k = 0; k < 3; ++k) {
        gradient[0][k] = (by * du[0][k] - ay * du[1][k]) / determinant;
        gradient[1][k] = (ax * du[1][k] - bx * du[0][k]) / determinant;
    }
    out_strain[0] = ss_dot3(gradient[0], x);
    out_strain[1] = ss_dot3(gradient[1], y);
    out_strain[2] = 0.0;
    out_strain[3] = ss_dot3(gradient[1], n);
    out_strain[4] = ss_dot3(gradient[0], n);
    out_strain[5] = ss_dot3(gradient[0], y) + ss_dot3(gradient[1], x);
    return area;
}

/* (5): mean of sigma:eps over the star. */
static double density(const ss_zhong_motion *m, const double (*u)[3])
{
    double sum = 0.0, area_sum = 0.0;
    for (int32_t t = 0; t < m->triangle_count; ++t) {
        double strain[6];
        const double area = triangle_strain(m, u, m->star[t], strain);
        for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < 6; ++j) {
                sum += area * strain[i] * m->law->tensor[i][j] * strain[j];
            }
        }
        area_sum += area;
    }
    return sum / area_sum;
}

static double current(const ss_zhong_motion *m, const double (*u)[3])
{
    switch (m->law->source) {
    case SS_ZHONG_WORK:
        return fmax(0.0, ss_dot3(m->force, u[m->contact]) / m->net->area[m->contact]);
    case SS_ZHONG_DENSITY:
        return density(m, u);
    case SS_ZHONG_CLOSURE:
        break;
    }
    return m->law->modulus * fmax(0.0, ss_zhong_net_strain(m->net, u) / m->net->flux_strain);
}

double ss_zhong_motion_current(const ss_zhong_motion *motion)
{
    return current(motion, (const double(*)[3])motion->u);
}

/* (26) to (28): P'' at u, v. */
static void accelerate(const ss_zhong_motion *m, const double (*u)[3], const double (*v)[3],
                       double (*out)[3])
{
    const ss_zhong_net *net = m->net;
    const ss_zhong_law *law = m->law;
    const double amperes = current(m, u);
    for (int32_t i = 0; i < net->node_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            out[i][k] = -law->damping * v[i][k] - law->rest_stiffness * u[i][k];
        }
    }
    ss_add3(out[m->contact], out[m->contact], m->force);
    for (int32_t e = 0; e < net->edge_count; ++e) {
        const int32_t i = net->edge[e][0], j = net->edge[e][1];
        double d[3], moved[3];
        ss_sub3(d, net->rest[j], net->rest[i]);
        ss_sub3(moved, u[j], u[i]);
        ss_add3(d, d, moved);
        double pull = amperes * net->flux[e];
        if (law->is_length_current) {
            pull *= net->length[e] * net->length[e] / ss_dot3(d, d);
        }
        ss_madd3(out[i], out[i], pull, d);
        ss_madd3(out[j], out[j], -pull, d);
    }
    for (int32_t i = 0; i < net->node_count; ++i) {
        const double inverse = net->is_held[i] ? 0.0 : 1.0 / law->mass;
        ss_scale3(out[i], out[i], inverse);
    }
}

static void advance(int32_t count, double (*out)[3], const double (*from)[3], double h,
                    const double (*rate)[3])
{
    for (int32_t i = 0; i < count; ++i) {
        ss_madd3(out[i], from[i], h, rate[i]);
    }
}

void ss_zhong_motion_run(ss_zhong_motion *motion, int32_t count, double dt)
{
    static const double share[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    static const double ahead[4] = {0.5, 0.5, 1.0, 0.0};
    const int32_t n = motion->net->node_count;
    double(*us)[3] = motion->scratch, (*vs)[3] = us + n, (*rate)[3] = vs + n;
    double(*new_u)[3] = rate + n, (*new_v)[3] = new_u + n, (*speed)[3] = new_v + n;
    const size_t size = (size_t)n * sizeof *us;
    for (int32_t step = 0; step < count; ++step) {
        memcpy(us, motion->u, size);
        memcpy(vs, motion->v, size);
        memcpy(new_u, motion->u, size);
        memcpy(new_v, motion->v, size);
        for (int s = 0; s < 4; ++s) {
            accelerate(motion, (const double(*)[3])us, (const double(*)[3])vs, rate);
            memcpy(speed, vs, size);
            advance(n, new_u, (const double(*)[3])new_u, share[s] * dt, (const double(*)[3])speed);
            advance(n, new_v, (const double(*)[3])new_v, share[s] * dt, (const double(*)[3])rate);
            advance(n, us, (const double(*)[3])motion->u, ahead[s] * dt, (const double(*)[3])speed);
            advance(n, vs, (const double(*)[3])motion->v, ahead[s] * dt, (const double(*)[3])rate);
        }
        memcpy(motion->u, new_u, size);
        memcpy(motion->v, new_v, size);
        motion->time += dt;
    }
}

double ss_zhong_motion_shortest(const ss_zhong_motion *motion)
{
    const ss_zhong_net *net = motion->net;
    double shortest = (double)INFINITY;
    for (int32_t e = 0; e < net->edge_count; ++e) {
        double d[3], moved[3];
        ss_sub3(d, net->rest[net->edge[e][1]], net->rest[net->edge[e][0]]);
        ss_sub3(moved, motion->u[net->edge[e][1]], motion->u[net->edge[e][0]]);
        ss_add3(d, d, moved);
        shortest = fmin(shortest, ss_norm3(d) / net->length[e]);
    }
    return shortest;
}
