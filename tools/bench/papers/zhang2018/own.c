/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/papers/zhang2018/own.h"
#include "rt/each.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- links ---- */

/* Each edge once: lists of higher neighbours by lower node. */
static bool find_links(ss_zhang_own *own, const ss_zhang_own_plan *plan)
{
    static const int ring[4][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    static const int all[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    const bool is_solid = plan->corners < 0;
    const int edges = is_solid ? 6 : 4;
    const size_t most = (size_t)plan->element_count * (size_t)edges;
    int32_t *head = malloc((size_t)plan->node_count * sizeof *head);
    int32_t *next = malloc(most * sizeof *next);
    own->link = malloc(most * sizeof *own->link);
    if (head == NULL || next == NULL || own->link == NULL) {
        free(head);
        free(next);
        return false;
    }
    for (int32_t i = 0; i < plan->node_count; ++i) {
        head[i] = -1;
    }
    for (int32_t e = 0; e < plan->element_count; ++e) {
        for (int s = 0; s < edges; ++s) {
            const int32_t p = plan->element[e][is_solid ? all[s][0] : ring[s][0]];
            const int32_t q = plan->element[e][is_solid ? all[s][1] : ring[s][1]];
            const int32_t low = p < q ? p : q, high = p < q ? q : p;
            int32_t at = head[low];
            while (at >= 0 && own->link[at][1] != high) {
                at = next[at];
            }
            if (at < 0) {
                own->link[own->link_count][0] = low;
                own->link[own->link_count][1] = high;
                next[own->link_count] = head[low];
                head[low] = own->link_count++;
            }
        }
    }
    free(head);
    free(next);
    return true;
}

/* Lengths, weights, and the step: max over links of the weighted valences of both ends. */
static bool measure_links(ss_zhang_own *own, const ss_zhang_own_plan *plan)
{
    const size_t links = (size_t)own->link_count;
    double *valence = calloc((size_t)own->node_count, sizeof *valence), mean = 0.0, most = 0.0;
    own->length = malloc(links * sizeof *own->length);
    own->weight = malloc(links * sizeof *own->weight);
    if (valence == NULL || own->length == NULL || own->weight == NULL) {
        free(valence);
        return false;
    }
    for (int32_t l = 0; l < own->link_count; ++l) {
        const int32_t a = own->link[l][0], b = own->link[l][1];
        const double *p = own->rest[a], *q = own->rest[b];
        own->length[l] = sqrt((q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1]) +
                              (q[2] - p[2]) * (q[2] - p[2]));
        own->weight[l] = plan->stiffness_of != NULL
                             ? 0.5 * (plan->stiffness_of[a] + plan->stiffness_of[b])
                             : plan->stiffness;
        mean += own->weight[l] / own->link_count;
    }
    own->stiffness = mean;
    for (int32_t l = 0; l < own->link_count; ++l) {
        own->weight[l] /= mean;
        valence[own->link[l][0]] += own->weight[l];
        valence[own->link[l][1]] += own->weight[l];
    }
    for (int32_t l = 0; l < own->link_count; ++l) {
        most = fmax(most, valence[own->link[l][0]] + valence[own->link[l][1]]);
    }
    own->stable_step = 4.0 * own->capacitance / most;
    free(valence);
    return true;
}

bool ss_zhang_own_init(ss_zhang_own *own, const ss_zhang_own_plan *plan)
{
    const size_t n = (size_t)plan->node_count;
    *own = (ss_zhang_own){.node_count = plan->node_count,
                          .pushed = plan->pushed,
                          .pushed_count = plan->pushed_count,
                          .alpha = plan->alpha,
                          .capacitance = plan->capacitance,
                          .share = 1.0,
                          .rule = plan->rule};
    memcpy(own->direction, plan->direction, sizeof own->direction);
    own->rest = malloc(n * sizeof *own->rest);
    own->at = malloc(n * sizeof *own->at);
    own->flow = calloc(n, sizeof *own->flow);
    own->is_held = calloc(n, 1);
    if (own->rest == NULL || own->at == NULL || own->flow == NULL || own->is_held == NULL) {
        ss_zhang_own_fini(own);
        return false;
    }
    memcpy(own->rest, plan->rest, n * sizeof *own->rest);
    memcpy(own->at, plan->rest, n * sizeof *own->at);
    for (size_t i = 0; i < n; ++i) {
        own->is_held[i] = plan->fixed[i] != 0;
    }
    for (int32_t k = 0; k < plan->pushed_count; ++k) {
        own->is_held[plan->pushed[k]] = 1;
    }
    if (!find_links(own, plan) || !measure_links(own, plan)) {
        ss_zhang_own_fini(own);
        return false;
    }
    return true;
}

void ss_zhang_own_fini(ss_zhang_own *own)
{
    SS_EACH(free, own->rest, own->at, own->flow, own->link, own->length, own->weight, own->is_held);
    *own = (ss_zhang_own){.node_count = 0};
}

/* ---- equations ---- */

/* (12), (13): dP at the places `at`. */
static void find_flow(ss_zhang_own *own, const double (*at)[3])
{
    const double alpha = own->alpha * own->share;
    memset(own->flow, 0, (size_t)own->node_count * sizeof *own->flow);
    for (int32_t l = 0; l < own->link_count; ++l) {
        const int32_t a = own->link[l][0], b = own->link[l][1];
        const double d[3] = {at[b][0] - at[a][0], at[b][1] - at[a][1], at[b][2] - at[a][2]};
        const double u = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        const double longest = (1.0 + alpha) * own->length[l];
        const double shortest = fmax(0.0, (1.0 - alpha) * own->length[l]);
        double mu = 0.0;
        if (u > longest) {
            mu = 0.5 * own->weight[l] * (u - longest) / u;
        } else if (u < shortest) {
            mu = 0.5 * own->weight[l] * (u - shortest) / u;
        }
        for (int k = 0; k < 3; ++k) {
            own->flow[a][k] += mu * d[k];
            own->flow[b][k] -= mu * d[k];
        }
    }
}

/* The share of alpha that acts while the patch goes back. */
static void unload(ss_zhang_own *own)
{
    own->deepest = fmax(own->deepest, own->depth);
    if (own->rule == SS_OWN_RAMP && own->deepest > 0.0) {
        own->share = own->depth / own->deepest;
    } else if (own->rule == SS_OWN_LITERAL && own->depth < 0.999 * own->deepest) {
        own->share = 0.0;
    }
}

void ss_zhang_own_step(ss_zhang_own *own, double depth, double h)
{
    own->depth = depth;
    unload(own);
    for (int32_t k = 0; k < own->pushed_count; ++k) {
        for (int a = 0; a < 3; ++a) {
            own->at[own->pushed[k]][a] = own->rest[own->pushed[k]][a] + depth * own->direction[a];
        }
    }
    find_flow(own, (const double(*)[3])own->at);
    own->force = 0.0;
    for (int32_t k = 0; k < own->pushed_count; ++k) {
        for (int a = 0; a < 3; ++a) {
            own->force -= 2.0 * own->stiffness * own->flow[own->pushed[k]][a] * own->direction[a];
        }
    }
    for (int32_t i = 0; i < own->node_count; ++i) {
        for (int a = 0; a < 3 && !own->is_held[i]; ++a) {
            own->at[i][a] += h / own->capacitance * own->flow[i][a];
        }
    }
}

void ss_zhang_own_go(ss_zhang_own *own, double depth, double speed, double h)
{
    const double from = own->depth, way = fabs(depth - from);
    const int32_t steps = (int32_t)ceil(way / (speed * h) - 1e-9);
    for (int32_t k = 1; k <= steps; ++k) {
        const double gone = fmin(k * speed * h, way);
        ss_zhang_own_step(own, k == steps ? depth : from + (depth > from ? gone : -gone), h);
    }
}

void ss_zhang_own_hold(ss_zhang_own *own, double time, double h)
{
    const int32_t steps = (int32_t)ceil(time / h - 1e-9);
    for (int32_t k = 0; k < steps; ++k) {
        ss_zhang_own_step(own, own->depth, h);
    }
}

/* ---- equilibrium ---- */

bool ss_zhang_own_settle(ss_zhang_own *own, double least)
{
    enum { MOST = 200000 };
    const size_t n = (size_t)own->node_count;
    const double rate = 0.5 * own->stable_step / own->capacitance; /* 1 over the curvature of W */
    double(*ahead)[3] = malloc(n * sizeof *ahead), mean = 0.0, momentum = 1.0;
    bool is_settled = false;
    for (int32_t l = 0; l < own->link_count; ++l) {
        mean += own->length[l] / own->link_count;
    }
    if (ahead == NULL) {
        return false;
    }
    memcpy(ahead, own->at, n * sizeof *ahead);
    for (int32_t step = 0; step < MOST && !is_settled; ++step) {
        const double after = 0.5 * (1.0 + sqrt(1.0 + 4.0 * momentum * momentum));
        const double carry = (momentum - 1.0) / after;
        double largest = 0.0, against = 0.0;
        find_flow(own, (const double(*)[3])ahead);
        for (int32_t i = 0; i < own->node_count; ++i) {
            for (int a = 0; a < 3 && !own->is_held[i]; ++a) {
                const double fresh = ahead[i][a] + rate * own->flow[i][a];
                const double moved = fresh - own->at[i][a];
                largest = fmax(largest, fabs(own->flow[i][a]));
                against += own->flow[i][a] * moved;
                own->at[i][a] = fresh;
                ahead[i][a] = fresh + carry * moved;
            }
        }
        momentum = after;
        if (against < 0.0) { /* it goes uphill: start again from here */
            momentum = 1.0;
            memcpy(ahead, own->at, n * sizeof *ahead);
        }
        is_settled = largest < least * mean;
    }
    free(ahead);
    ss_zhang_own_step(own, own->depth, 0.0);
    return is_settled;
}

/* ---- traditional ChainMail ---- */

void ss_zhang_own_row(int32_t count, double alpha, double depth, int32_t steps, double (*out_at)[2])
{
    for (int32_t i = 0; i < count; ++i) {
        out_at[i][0] = i;
        out_at[i][1] = 0.0;
    }
    for (int32_t s = 1; s <= steps; ++s) {
        out_at[0][1] = depth * s / steps;
        for (int32_t i = 1; i + 1 < count; ++i) {
            const double along = out_at[i][0] - out_at[i - 1][0];
            const double across = out_at[i][1] - out_at[i - 1][1];
            const double u = hypot(along, across);
            const double wanted = fmin(fmax(u, 1.0 - alpha), 1.0 + alpha);
            if (wanted == u) {
                break; /* what has not moved moves nothing */
            }
            out_at[i][0] = out_at[i - 1][0] + along * wanted / u;
            out_at[i][1] = out_at[i - 1][1] + across * wanted / u;
        }
    }
}
