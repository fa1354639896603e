/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/papers/zhang2018/reference.h"
#include "rt/each.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- links ---- */

/* Each edge once: lists of higher neighbours by lower node. */
static bool find_links(ss_zhang_reference *reference, const ss_zhang_reference_plan *plan)
{
    static const int ring[4][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    static const int all[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    const bool is_solid = plan->corners < 0;
    const int edges = is_solid ? 6 : 4;
    const size_t most = (size_t)plan->element_count * (size_t)edges;
    int32_t *head = malloc((size_t)plan->node_count * sizeof *head);
    int32_t *next = malloc(most * sizeof *next);
    reference->link = malloc(most * sizeof *reference->link);
    if (head == NULL || next == NULL || reference->link == NULL) {
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
            while (at >= 0 && reference->link[at][1] != high) {
                at = next[at];
            }
            if (at < 0) {
                reference->link[reference->link_count][0] = low;
                reference->link[reference->link_count][1] = high;
                next[reference->link_count] = head[low];
                head[low] = reference->link_count++;
            }
        }
    }
    free(head);
    free(next);
    return true;
}

/* Lengths, weights, and the step: max over links of the weighted valences of both ends. */
static bool measure_links(ss_zhang_reference *reference, const ss_zhang_reference_plan *plan)
{
    const size_t links = (size_t)reference->link_count;
    double *valence = calloc((size_t)reference->node_count, sizeof *valence), mean = 0.0,
           most = 0.0;
    reference->length = malloc(links * sizeof *reference->length);
    reference->weight = malloc(links * sizeof *reference->weight);
    if (valence == NULL || reference->length == NULL || reference->weight == NULL) {
        free(valence);
        return false;
    }
    for (int32_t l = 0; l < reference->link_count; ++l) {
        const int32_t a = reference->link[l][0], b = reference->link[l][1];
        const double *p = reference->rest[a], *q = reference->rest[b];
        reference->length[l] = sqrt((q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1]) +
                                    (q[2] - p[2]) * (q[2] - p[2]));
        reference->weight[l] = plan->stiffness_of != NULL
                                   ? 0.5 * (plan->stiffness_of[a] + plan->stiffness_of[b])
                                   : plan->stiffness;
    }
    for (int32_t i = 0; i < reference->node_count; ++i) {
        const double k = plan->stiffness_of != NULL ? plan->stiffness_of[i] : plan->stiffness;
        mean += k / reference->node_count;
    }
    reference->stiffness = mean;
    for (int32_t l = 0; l < reference->link_count; ++l) {
        reference->weight[l] /= mean;
        valence[reference->link[l][0]] += reference->weight[l];
        valence[reference->link[l][1]] += reference->weight[l];
    }
    for (int32_t l = 0; l < reference->link_count; ++l) {
        most = fmax(most, valence[reference->link[l][0]] + valence[reference->link[l][1]]);
    }
    reference->stable_step = 4.0 * reference->capacitance / most;
    free(valence);
    return true;
}

ss_zhang_reference_plan ss_zhang_reference_on(const ss_mesh *mesh, const uint8_t *fixed,
                                              const int32_t *pushed, int32_t pushed_count)
{
    const bool is_flat = mesh->quad_count > 0;
    return (ss_zhang_reference_plan){
        .node_count = mesh->node_count,
        .element_count = is_flat ? mesh->quad_count : mesh->tetrahedron_count,
        .corners = is_flat ? 4 : -4,
        .rest = (const double(*)[3])mesh->position,
        .element = (const int32_t(*)[4])(is_flat ? mesh->quad : mesh->tetrahedron),
        .fixed = fixed,
        .pushed = pushed,
        .pushed_count = pushed_count};
}

bool ss_zhang_reference_init(ss_zhang_reference *reference, const ss_zhang_reference_plan *plan)
{
    const size_t n = (size_t)plan->node_count;
    *reference = (ss_zhang_reference){.node_count = plan->node_count,
                                      .pushed = plan->pushed,
                                      .pushed_count = plan->pushed_count,
                                      .alpha = plan->alpha,
                                      .capacitance = plan->capacitance,
                                      .share = 1.0,
                                      .rule = plan->rule};
    memcpy(reference->direction, plan->direction, sizeof reference->direction);
    reference->rest = malloc(n * sizeof *reference->rest);
    reference->at = malloc(n * sizeof *reference->at);
    reference->flow = calloc(n, sizeof *reference->flow);
    reference->is_held = calloc(n, 1);
    if (reference->rest == NULL || reference->at == NULL || reference->flow == NULL ||
        reference->is_held == NULL) {
        ss_zhang_reference_fini(reference);
        return false;
    }
    memcpy(reference->rest, plan->rest, n * sizeof *reference->rest);
    memcpy(reference->at, plan->rest, n * sizeof *reference->at);
    for (size_t i = 0; i < n; ++i) {
        reference->is_held[i] = plan->fixed[i] != 0;
    }
    for (int32_t k = 0; k < plan->pushed_count; ++k) {
        reference->is_held[plan->pushed[k]] = 1;
    }
    if (!find_links(reference, plan) || !measure_links(reference, plan)) {
        ss_zhang_reference_fini(reference);
        return false;
    }
    return true;
}

void ss_zhang_reference_fini(ss_zhang_reference *reference)
{
    SS_EACH(free, reference->rest, reference->at, reference->flow, reference->link,
            reference->length, reference->weight, reference->is_held);
    *reference = (ss_zhang_reference){.node_count = 0};
}

/* ---- equations ---- */

/* (12), (13): dP at the places `at`. */
static void find_flow(ss_zhang_reference *reference, const double (*at)[3])
{
    const double alpha = reference->alpha * reference->share;
    memset(reference->flow, 0, (size_t)reference->node_count * sizeof *reference->flow);
    for (int32_t l = 0; l < reference->link_count; ++l) {
        const int32_t a = reference->link[l][0], b = reference->link[l][1];
        const double d[3] = {at[b][0] - at[a][0], at[b][1] - at[a][1], at[b][2] - at[a][2]};
        const double u = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        const double longest = (1.0 + alpha) * reference->length[l];
        const double shortest = fmax(0.0, (1.0 - alpha) * reference->length[l]);
        double mu = 0.0;
        if (u > longest) {
            mu = 0.5 * reference->weight[l] * (u - longest) / u;
        } else if (u < shortest) {
            mu = 0.5 * reference->weight[l] * (u - shortest) / u;
        }
        for (int k = 0; k < 3; ++k) {
            reference->flow[a][k] += mu * d[k];
            reference->flow[b][k] -= mu * d[k];
        }
    }
}

/* The share of alpha that acts while the patch goes back. */
static void unload(ss_zhang_reference *reference)
{
    reference->deepest = fmax(reference->deepest, reference->depth);
    if (reference->rule == SS_REFERENCE_RAMP && reference->deepest > 0.0) {
        reference->share = reference->depth / reference->deepest;
    } else if (reference->rule == SS_REFERENCE_LITERAL &&
               reference->depth < 0.999 * reference->deepest) {
        reference->share = 0.0;
    }
}

void ss_zhang_reference_step(ss_zhang_reference *reference, double depth, double h)
{
    reference->depth = depth;
    unload(reference);
    for (int32_t k = 0; k < reference->pushed_count; ++k) {
        for (int a = 0; a < 3; ++a) {
            reference->at[reference->pushed[k]][a] =
                reference->rest[reference->pushed[k]][a] + depth * reference->direction[a];
        }
    }
    find_flow(reference, (const double(*)[3])reference->at);
    reference->force = 0.0;
    for (int32_t k = 0; k < reference->pushed_count; ++k) {
        for (int a = 0; a < 3; ++a) {
            reference->force -= 2.0 * reference->stiffness *
                                reference->flow[reference->pushed[k]][a] * reference->direction[a];
        }
    }
    for (int32_t i = 0; i < reference->node_count; ++i) {
        for (int a = 0; a < 3 && !reference->is_held[i]; ++a) {
            reference->at[i][a] += h / reference->capacitance * reference->flow[i][a];
        }
    }
}

void ss_zhang_reference_go(ss_zhang_reference *reference, double depth, double speed, double h)
{
    const double from = reference->depth, way = fabs(depth - from);
    const int32_t steps = (int32_t)ceil(way / (speed * h) - 1e-9);
    for (int32_t k = 1; k <= steps; ++k) {
        const double gone = fmin(k * speed * h, way);
        ss_zhang_reference_step(reference,
                                k == steps ? depth : from + (depth > from ? gone : -gone), h);
    }
}

void ss_zhang_reference_hold(ss_zhang_reference *reference, double time, double h)
{
    const int32_t steps = (int32_t)ceil(time / h - 1e-9);
    for (int32_t k = 0; k < steps; ++k) {
        ss_zhang_reference_step(reference, reference->depth, h);
    }
}

void ss_zhang_reference_at_once(ss_zhang_reference *reference, double depth, double h,
                                int32_t parts)
{
    const double from = reference->depth;
    for (int32_t k = 1; k <= parts; ++k) {
        ss_zhang_reference_step(reference, from + (depth - from) * k / parts, h / parts);
    }
}

/* ---- equilibrium ---- */

bool ss_zhang_reference_settle(ss_zhang_reference *reference, double least)
{
    enum { MOST = 200000 };
    const size_t n = (size_t)reference->node_count;
    const double rate =
        0.5 * reference->stable_step / reference->capacitance; /* 1 over the curvature of W */
    double(*ahead)[3] = malloc(n * sizeof *ahead), mean = 0.0, momentum = 1.0;
    bool is_settled = false;
    for (int32_t l = 0; l < reference->link_count; ++l) {
        mean += reference->length[l] / reference->link_count;
    }
    if (ahead == NULL) {
        return false;
    }
    memcpy(ahead, reference->at, n * sizeof *ahead);
    for (int32_t step = 0; step < MOST && !is_settled; ++step) {
        const double after = 0.5 * (1.0 + sqrt(1.0 + 4.0 * momentum * momentum));
        const double carry = (momentum - 1.0) / after;
        double largest = 0.0, against = 0.0;
        find_flow(reference, (const double(*)[3])ahead);
        for (int32_t i = 0; i < reference->node_count; ++i) {
            for (int a = 0; a < 3 && !reference->is_held[i]; ++a) {
                const double fresh = ahead[i][a] + rate * reference->flow[i][a];
                const double moved = fresh - reference->at[i][a];
                largest = fmax(largest, fabs(reference->flow[i][a]));
                against += reference->flow[i][a] * moved;
                reference->at[i][a] = fresh;
                ahead[i][a] = fresh + carry * moved;
            }
        }
        momentum = after;
        if (against < 0.0) { /* it goes uphill: start again from here */
            momentum = 1.0;
            memcpy(ahead, reference->at, n * sizeof *ahead);
        }
        is_settled = largest < least * mean;
    }
    free(ahead);
    ss_zhang_reference_step(reference, reference->depth, 0.0);
    return is_settled;
}

/* ---- traditional ChainMail ---- */

void ss_zhang_reference_row(int32_t count, double alpha, double depth, int32_t steps,
                            double (*out_at)[2])
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
