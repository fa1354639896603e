/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/accuracy/refine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/order.h"
#include "rt/vec.h"

/* An edge of the coarse mesh, its lower node first. */
typedef struct edge {
    int32_t a, b;
} edge;

typedef struct edges {
    edge *edge; /* sorted, each once */
    int32_t count;
} edges;

static const int corner[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

static int by_nodes(const void *x, const void *y)
{
    const edge *p = x, *q = y;
    return ss_order_then(ss_order_int(p->a, q->a), ss_order_int(p->b, q->b));
}

static edge edge_of(int32_t a, int32_t b)
{
    return a < b ? (edge){a, b} : (edge){b, a};
}

static bool list_edges(const ss_mesh *mesh, edges *out)
{
    const size_t room = 6 * (size_t)mesh->tetrahedron_count;
    out->edge = calloc(room + 1, sizeof *out->edge);
    if (out->edge == NULL) {
        return false;
    }
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        for (int k = 0; k < 6; ++k) {
            out->edge[6 * (size_t)t + (size_t)k] =
                edge_of(mesh->tetrahedron[t][corner[k][0]], mesh->tetrahedron[t][corner[k][1]]);
        }
    }
    qsort(out->edge, room, sizeof *out->edge, by_nodes);
    for (size_t i = 0; i < room; ++i) {
        if (i == 0 || by_nodes(&out->edge[i], &out->edge[i - 1]) != 0) {
            out->edge[out->count++] = out->edge[i];
        }
    }
    return true;
}

static int32_t find_edge(const edges *list, int32_t a, int32_t b)
{
    const edge key = edge_of(a, b);
    const edge *at = bsearch(&key, list->edge, (size_t)list->count, sizeof key, by_nodes);
    return (int32_t)(at - list->edge);
}

static double distance2(const double (*x)[3], int32_t a, int32_t b)
{
    double d[3];
    ss_sub3(d, x[a], x[b]);
    return ss_dot3(d, d);
}

/* Eight of one. m[k]: the middle of edge corner[k]; middles 0-5, 1-4 and 2-3 face one another. */
static void cut(const double (*x)[3], const int32_t v[4], const int32_t m[6], int32_t (*out)[4])
{
    static const int around[3][6] = {{0, 5, 1, 2, 4, 3}, {1, 4, 0, 3, 5, 2}, {2, 3, 0, 1, 5, 4}};
    int best = 0;
    for (int k = 1; k < 3; ++k) {
        best = distance2(x, m[around[k][0]], m[around[k][1]]) <
                       distance2(x, m[around[best][0]], m[around[best][1]])
                   ? k
                   : best;
    }
    const int32_t ends[4][4] = {{v[0], m[0], m[1], m[2]},
                                {m[0], v[1], m[3], m[4]},
                                {m[1], m[3], v[2], m[5]},
                                {m[2], m[4], m[5], v[3]}};
    memcpy(out, ends, sizeof ends);
    const int *r = around[best];
    for (int k = 0; k < 4; ++k) {
        const int32_t part[4] = {m[r[0]], m[r[1]], m[r[2 + k]], m[r[2 + (k + 1) % 4]]};
        double a[3], b[3], c[3], n[3];
        memcpy(out[4 + k], part, sizeof part);
        ss_sub3(a, x[part[1]], x[part[0]]);
        ss_sub3(b, x[part[2]], x[part[0]]);
        ss_sub3(c, x[part[3]], x[part[0]]);
        ss_cross3(n, a, b);
        if (ss_dot3(n, c) < 0.0) {
            out[4 + k][2] = part[3];
            out[4 + k][3] = part[2];
        }
    }
}

static softsim_status refine_mesh(const ss_mesh *mesh, const edges *list, ss_mesh **out,
                                  softsim_error *error)
{
    const int32_t n = mesh->node_count;
    const size_t nodes = (size_t)n + (size_t)list->count;
    double(*x)[3] = calloc(nodes, sizeof *x);
    int32_t(*t)[4] = calloc(8 * (size_t)mesh->tetrahedron_count, sizeof *t);
    softsim_status status = SOFTSIM_ERROR_MEMORY;
    if (x == NULL || t == NULL) {
        ss_memory_fault(error);
    } else {
        memcpy(x, mesh->position, (size_t)n * sizeof *x);
        for (int32_t e = 0; e < list->count; ++e) {
            ss_add3(x[n + e], x[list->edge[e].a], x[list->edge[e].b]);
            ss_scale3(x[n + e], x[n + e], 0.5);
        }
        for (int32_t k = 0; k < mesh->tetrahedron_count; ++k) {
            const int32_t *v = mesh->tetrahedron[k];
            int32_t m[6];
            for (int i = 0; i < 6; ++i) {
                m[i] = n + find_edge(list, v[corner[i][0]], v[corner[i][1]]);
            }
            cut((const double(*)[3])x, v, m, &t[8 * (size_t)k]);
        }
        status = ss_mesh_create((int32_t)nodes, (const double(*)[3])x, 0, NULL,
                                8 * mesh->tetrahedron_count, (const int32_t(*)[4])t, out, error);
    }
    free(x);
    free(t);
    return status;
}

/* Nodes with a value (`value` NULL: 1) and the middles between two of them. */
static bool refine_set(int32_t node_count, const edges *list, int32_t count, const int32_t *node,
                       const double *value, int32_t *out_count, int32_t **out_node,
                       double **out_value)
{
    double *at = calloc((size_t)node_count, sizeof *at);
    uint8_t *mark = calloc((size_t)node_count, 1);
    const size_t room = (size_t)count + (size_t)list->count + 1;
    *out_node = calloc(room, sizeof **out_node);
    double *kept = calloc(room, sizeof *kept);
    const bool is_good = at != NULL && mark != NULL && *out_node != NULL && kept != NULL;
    for (int32_t i = 0; i < count && is_good; ++i) {
        mark[node[i]] = 1;
        at[node[i]] = value != NULL ? value[i] : 1.0;
        (*out_node)[*out_count] = node[i];
        kept[(*out_count)++] = at[node[i]];
    }
    for (int32_t e = 0; e < list->count && is_good; ++e) {
        const edge *side = &list->edge[e];
        if (mark[side->a] != 0 && mark[side->b] != 0) {
            (*out_node)[*out_count] = node_count + e;
            kept[(*out_count)++] = 0.5 * (at[side->a] + at[side->b]);
        }
    }
    free(at);
    free(mark);
    if (out_value != NULL) {
        *out_value = kept;
    } else {
        free(kept);
    }
    return is_good;
}

void ss_refine_volumes(const ss_mesh *mesh, double *out)
{
    memset(out, 0, (size_t)mesh->node_count * sizeof *out);
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        const int32_t *v = mesh->tetrahedron[t];
        double a[3], b[3], c[3], n[3];
        ss_sub3(a, mesh->position[v[1]], mesh->position[v[0]]);
        ss_sub3(b, mesh->position[v[2]], mesh->position[v[0]]);
        ss_sub3(c, mesh->position[v[3]], mesh->position[v[0]]);
        ss_cross3(n, a, b);
        for (int k = 0; k < 4; ++k) {
            out[v[k]] += fabs(ss_dot3(n, c)) / 24.0;
        }
    }
}

static bool fill(const ss_case_body *coarse, const edges *list, ss_case_body *out)
{
    const int32_t n = coarse->mesh->node_count, count = out->mesh->node_count;
    out->number = calloc((size_t)count, sizeof *out->number);
    out->weight = calloc((size_t)count, sizeof *out->weight);
    if (out->number == NULL || out->weight == NULL) {
        return false;
    }
    for (int32_t i = 0; i < count; ++i) {
        out->number[i] = i + 1;
    }
    ss_refine_volumes(out->mesh, out->weight);
    return refine_set(n, list, coarse->fixed_count, coarse->fixed, NULL, &out->fixed_count,
                      &out->fixed, NULL) &&
           refine_set(n, list, coarse->pressed_count, coarse->pressed, NULL, &out->pressed_count,
                      &out->pressed, NULL) &&
           refine_set(n, list, coarse->pushed_count, coarse->pushed, coarse->profile,
                      &out->pushed_count, &out->pushed, &out->profile);
}

softsim_status ss_refine(const ss_case_body *coarse, ss_case_body *out, softsim_error *error)
{
    edges list = {.edge = NULL};
    *out = (ss_case_body){.mesh = NULL};
    softsim_status status = list_edges(coarse->mesh, &list) ? SOFTSIM_OK : ss_memory_fault(error);
    if (status == SOFTSIM_OK) {
        status = refine_mesh(coarse->mesh, &list, &out->mesh, error);
    }
    if (status == SOFTSIM_OK && !fill(coarse, &list, out)) {
        status = ss_memory_fault(error);
    }
    free(list.edge);
    return status;
}
