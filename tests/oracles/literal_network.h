/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The network's equations (1), (2) and (20) as they stand, one cell at a time: slow, and nothing to
 * get wrong. cmocka comes first.
 */
#include <math.h>
#include <stdlib.h>

#include "common/model_fixture.h"

typedef struct literal {
    const setup *s;
    double resistance, saturation;
    double *v, *y, *flow;
} literal;

static inline void literal_init(literal *net, const setup *s, double resistance, double saturation)
{
    const size_t n = (size_t)s->mesh->node_count;
    *net = (literal){.s = s, .resistance = resistance, .saturation = saturation};
    net->v = calloc(n, sizeof(double));
    net->y = calloc(n, sizeof(double));
    net->flow = calloc(n, sizeof(double));
}

static inline void literal_fini(literal *net)
{
    free(net->v);
    free(net->y);
    free(net->flow);
}

static inline double literal_rho(const setup *s, int32_t i)
{
    return s->model->material.rho[i];
}

/* v += dt (-v/R + sum_j A_ij y_j + I), A_ii = 1/R - sum_j A_ij. */
static inline void literal_step(literal *net, const double *current, double dt)
{
    const ss_cnn_network *network = net->s->model->network;
    const int32_t n = net->s->mesh->node_count;
    for (int32_t i = 0; i < n; ++i) {
        net->y[i] = fmax(-net->saturation, fmin(net->saturation, net->v[i]));
        net->flow[i] = -net->v[i] / net->resistance + net->y[i] / net->resistance + current[i];
    }
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
        const double w = network->edge_weight[e];
        net->flow[i] += literal_rho(net->s, i) * w / network->size[i] * (net->y[j] - net->y[i]);
        net->flow[j] += literal_rho(net->s, j) * w / network->size[j] * (net->y[i] - net->y[j]);
    }
    for (int32_t i = 0; i < n; ++i) {
        net->v[i] = net->s->fixed[i] == 7 ? 0.0 : net->v[i] + dt * net->flow[i];
    }
}
