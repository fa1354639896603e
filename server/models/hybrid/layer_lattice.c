/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/layer.h"
/*
 * The places of the lattice: cell centres of a cubic grid over the surface's box, and where a finer
 * spacing is asked for, of the same grid cut in halves, quarters or eighths. The spacing at a place
 * is that of the nearest node of the mesh; a coarse cell is cut as its centre needs.
 *
 * In or out is decided for whole columns along x. A triangle that a column's line pierces changes
 * the winding number by the sign of its normal, so that each triangle marks the first place beyond
 * it and a running sum gives the winding number of every place: inside is above 0. Lines are moved
 * aside by an irrational share of the spacing, so that none meets an edge of a regular mesh.
 * Tetrahedra claim the places in their box by barycentric coordinates; on a shared face the first
 * one does. Rejected: a distance field per place (50 times the work), rays in any direction with
 * tests of parity (a ray through an edge counts twice).
 */
#include <math.h>
#include <string.h>

#include "models/hybrid/point_grid.h"
#include "rt/memory.h"
#include "rt/vec.h"

enum { MAX_LEVEL = 3, MAX_PLACES = 1 << 24 };

typedef struct lattice {
    const ss_layer_plan *plan;
    const ss_mesh *mesh;
    double low[3], spacing; /* m */
    int32_t n[3];
    int32_t *host;    /* -1 none */
    int16_t *winding; /* change of the winding number at each place, then the number */
    uint8_t *level;   /* by cell of the coarsest lattice; NULL: all 0 */
    int32_t coarse_n[3];
} lattice;

static int64_t place(const lattice *l, int32_t i, int32_t j, int32_t k)
{
    return ((int64_t)k * l->n[1] + j) * l->n[0] + i;
}

/* Range of places whose centres lie in low..high along axis k, clamped. */
static void range(const lattice *l, int k, double low, double high, int32_t *first, int32_t *last)
{
    const double from = ceil((low - l->low[k]) / l->spacing - 0.5);
    const double to = floor((high - l->low[k]) / l->spacing - 0.5);
    *first = (int32_t)fmin(fmax(from, 0.0), l->n[k]);
    *last = (int32_t)fmax(fmin(to, l->n[k] - 1.0), -1.0);
}

static double centre(const lattice *l, int k, int32_t i)
{
    return l->low[k] + (i + 0.5) * l->spacing;
}

/* ---- tetrahedra ---- */

static void claim(lattice *l, int32_t e)
{
    const int32_t *node = l->mesh->tetrahedron[e];
    const double *x0 = l->mesh->position[node[0]];
    double d[3][3], row[3][3];
    int32_t first[3], last[3];
    for (int a = 0; a < 3; ++a) {
        ss_sub3(d[a], l->mesh->position[node[a + 1]], x0);
    }
    ss_cross3(row[0], d[1], d[2]);
    ss_cross3(row[1], d[2], d[0]);
    ss_cross3(row[2], d[0], d[1]);
    const double determinant = ss_dot3(d[0], row[0]);
    const double slack = 1e-9 * l->spacing;
    for (int k = 0; k < 3; ++k) {
        double low = x0[k];
        double high = x0[k];
        for (int a = 0; a < 3; ++a) {
            low = fmin(low, x0[k] + d[a][k]);
            high = fmax(high, x0[k] + d[a][k]);
        }
        range(l, k, low - slack, high + slack, &first[k], &last[k]);
    }
    for (int32_t k = first[2]; k <= last[2]; ++k) {
        for (int32_t j = first[1]; j <= last[1]; ++j) {
            for (int32_t i = first[0]; i <= last[0]; ++i) {
                const double x[3] = {centre(l, 0, i) - x0[0], centre(l, 1, j) - x0[1],
                                     centre(l, 2, k) - x0[2]};
                const double a = ss_dot3(row[0], x) / determinant;
                const double b = ss_dot3(row[1], x) / determinant;
                const double c = ss_dot3(row[2], x) / determinant;
                int32_t *host = &l->host[place(l, i, j, k)];
                if (*host < 0 && a >= -1e-9 && b >= -1e-9 && c >= -1e-9 &&
                    a + b + c <= 1.0 + 1e-9) {
                    *host = e;
                }
            }
        }
    }
}

/* ---- the surface ---- */

static void pierce(lattice *l, int32_t t)
{
    const double aside[2] = {1.41421356e-5 * l->spacing, 1.73205081e-5 * l->spacing};
    double x[3][3];
    int32_t first[3] = {0};
    int32_t last[3] = {0};
    for (int a = 0; a < 3; ++a) {
        ss_copy3(x[a], l->mesh->position[l->mesh->triangle[t][a]]);
        x[a][1] -= aside[0];
        x[a][2] -= aside[1];
    }
    for (int k = 1; k < 3; ++k) {
        range(l, k, fmin(x[0][k], fmin(x[1][k], x[2][k])), fmax(x[0][k], fmax(x[1][k], x[2][k])),
              &first[k], &last[k]);
    }
    /* Twice the signed area seen along x: > 0 where the normal points to +x. */
    const double area =
        (x[1][1] - x[0][1]) * (x[2][2] - x[0][2]) - (x[1][2] - x[0][2]) * (x[2][1] - x[0][1]);
    const int16_t change = area > 0.0 ? -1 : 1; /* towards +x one leaves where it points to +x */
    for (int32_t k = first[2]; k <= last[2] && area != 0.0; ++k) {
        for (int32_t j = first[1]; j <= last[1]; ++j) {
            const double y = centre(l, 1, j);
            const double z = centre(l, 2, k);
            double share[3];
            for (int a = 0; a < 3; ++a) {
                const double *p = x[(a + 1) % 3];
                const double *q = x[(a + 2) % 3];
                share[a] = ((p[1] - y) * (q[2] - z) - (p[2] - z) * (q[1] - y)) / area;
            }
            if (share[0] < 0.0 || share[1] < 0.0 || share[2] < 0.0) {
                continue;
            }
            const double at = share[0] * x[0][0] + share[1] * x[1][0] + share[2] * x[2][0];
            const double beyond = fmax(0.0, ceil((at - l->low[0]) / l->spacing - 0.5));
            if (beyond < l->n[0]) {
                l->winding[place(l, (int32_t)beyond, j, k)] =
                    (int16_t)(l->winding[place(l, (int32_t)beyond, j, k)] + change);
            }
        }
    }
}

static void wind(lattice *l)
{
    for (int32_t t = 0; t < l->mesh->triangle_count; ++t) {
        pierce(l, t);
    }
    for (int64_t column = 0; column < (int64_t)l->n[1] * l->n[2]; ++column) {
        int16_t number = 0;
        for (int32_t i = 0; i < l->n[0]; ++i) {
            int16_t *at = &l->winding[column * l->n[0] + i];
            number = (int16_t)(number + *at);
            *at = number;
        }
    }
}

/* ---- one level ---- */

static bool add_site(ss_layer_sites *sites, const ss_layer_site *site)
{
    ss_layer_site *all =
        ss_memory_grow(sites->site, sites->count, &sites->capacity, sizeof *sites->site);
    if (all == NULL) {
        return false;
    }
    sites->site = all;
    sites->site[sites->count++] = *site;
    return true;
}

static bool is_of_level(const lattice *l, int level, int32_t i, int32_t j, int32_t k)
{
    const int64_t cell =
        ((int64_t)(k >> level) * l->coarse_n[1] + (j >> level)) * l->coarse_n[0] + (i >> level);
    return l->level == NULL || l->level[cell] == level;
}

/* Adds the places of a level; false when out of memory. */
static bool scan(lattice *l, int level, ss_layer_sites *sites)
{
    const size_t places = (size_t)l->n[0] * (size_t)l->n[1] * (size_t)l->n[2];
    l->host = ss_memory_get(places, sizeof *l->host);
    l->winding = ss_memory_get(places, sizeof *l->winding);
    bool is_good = l->host != NULL && l->winding != NULL;
    if (is_good) {
        memset(l->host, 0xff, places * sizeof *l->host);
        for (int32_t e = 0; e < l->mesh->tetrahedron_count; ++e) {
            claim(l, e);
        }
        wind(l);
    }
    for (int32_t k = 0; is_good && k < l->n[2]; ++k) {
        for (int32_t j = 0; j < l->n[1]; ++j) {
            for (int32_t i = 0; i < l->n[0] && is_good; ++i) {
                const int64_t at = place(l, i, j, k);
                if ((l->host[at] >= 0 || l->winding[at] > 0) && is_of_level(l, level, i, j, k)) {
                    const ss_layer_site site = {
                        .x = {centre(l, 0, i), centre(l, 1, j), centre(l, 2, k)},
                        .spacing = l->spacing,
                        .host = l->host[at]};
                    is_good = add_site(sites, &site);
                }
            }
        }
    }
    ss_memory_free(l->host);
    ss_memory_free(l->winding);
    return is_good;
}

/* The level of each coarse cell from the spacing at the node nearest to its centre; the finest
 * level, or -1 when out of memory. */
static int choose_levels(lattice *l)
{
    const ss_layer_plan *plan = l->plan;
    ss_point_grid grid;
    ss_arena scratch = {0};
    memcpy(l->coarse_n, l->n, sizeof l->n);
    if (plan->spacing_of == NULL) {
        return 0;
    }
    const size_t cells = (size_t)l->n[0] * (size_t)l->n[1] * (size_t)l->n[2];
    l->level = ss_memory_get(cells, 1);
    if (l->level == NULL ||
        !ss_point_grid_init(&grid, l->mesh->node_count, (const double(*)[3])l->mesh->position,
                            2.0 * l->spacing, &scratch)) {
        ss_arena_free(&scratch);
        return -1;
    }
    int finest = 0;
    for (size_t c = 0; c < cells; ++c) {
        const int32_t i = (int32_t)(c % (size_t)l->n[0]);
        const int32_t j = (int32_t)(c / (size_t)l->n[0] % (size_t)l->n[1]);
        const int32_t k = (int32_t)(c / (size_t)l->n[0] / (size_t)l->n[1]);
        const double x[3] = {centre(l, 0, i), centre(l, 1, j), centre(l, 2, k)};
        int32_t node = 0;
        double square;
        ss_point_grid_nearest(&grid, x, 1, INFINITY, &node, &square);
        const double halvings = round(log2(l->spacing / plan->spacing_of[node]));
        l->level[c] = (uint8_t)fmin(fmax(halvings, 0.0), MAX_LEVEL);
        finest = l->level[c] > finest ? l->level[c] : finest;
    }
    ss_arena_free(&scratch);
    return finest;
}

softsim_status ss_layer_list_sites(const ss_layer_plan *plan, ss_layer_sites *out_sites,
                                   softsim_error *error)
{
    lattice l = {.plan = plan, .mesh = plan->mesh, .spacing = plan->spacing};
    double high[3];
    double places = 1.0;
    *out_sites = (ss_layer_sites){0};
    ss_bounds3(plan->mesh->node_count, (const double(*)[3])plan->mesh->position, l.low, high);
    for (int k = 0; k < 3; ++k) {
        const double cells = ceil((high[k] - l.low[k]) / plan->spacing - 1e-6);
        places *= fmax(cells, 1.0);
        l.n[k] = (int32_t)fmin(fmax(cells, 1.0), MAX_PLACES);
        l.low[k] -= 0.5 * (l.n[k] * plan->spacing - (high[k] - l.low[k]));
    }
    bool is_good = true;
    if (places <= MAX_PLACES) {
        const int finest = choose_levels(&l);
        is_good = finest >= 0;
        if (finest > 0 && places * pow(8.0, finest) > MAX_PLACES) {
            places *= pow(8.0, finest);
        }
        for (int level = 0; is_good && level <= finest && places <= MAX_PLACES; ++level) {
            is_good = scan(&l, level, out_sites);
            l.spacing *= 0.5;
            for (int k = 0; k < 3; ++k) {
                l.n[k] *= 2;
            }
        }
    }
    ss_memory_free(l.level);
    if (!is_good) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "out of memory for the layer's lattice");
        return SOFTSIM_ERROR_MEMORY;
    }
    if (places > MAX_PLACES) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "layer.spacing_m: %g m over this body makes a lattice of %.3g places, "
                          "more than %d; give a coarser spacing",
                          plan->spacing, places, (int)MAX_PLACES);
        return SOFTSIM_ERROR_SCENE;
    }
    return SOFTSIM_OK;
}
