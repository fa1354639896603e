/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Neighbouring rings of any sizes are joined like a zip: of the two next nodes the one at the lower
 * angle makes the next triangle, so that triangles stay even while rings grow and shrink. Rings
 * of 6 k nodes were rejected: on a long body they crowd.
 *
 * A prism over the triangle (a, b, c) is cut by the order of its columns (Dompierre et al. 1999):
 * of each side the diagonal starts below the column that comes first, so that neighbours agree and
 * no circle of diagonals arises. The order is by node number.
 */
#include "prism.h"

#include "rt/vec.h"

int64_t rings_node_count(const rings *r)
{
    int64_t count = 0;
    for (int32_t k = 0; k < r->ring_count; ++k) {
        count += r->size[k];
    }
    return count;
}

/* Every second ring is turned by half a step: triangles become equilateral. */
static double angle_of(const rings *r, int32_t ring, int32_t place)
{
    return 2.0 * SS_PI * (place + 0.5 * (ring & 1)) / r->size[ring];
}

static bool add_prisms(solid *s, int32_t stride, int32_t layers, int32_t a, int32_t b, int32_t c)
{
    int32_t order[3] = {a, b, c};
    for (int i = 0; i < 2; ++i) {
        for (int k = 0; k < 2; ++k) {
            if (order[k] > order[k + 1]) {
                const int32_t swap = order[k];
                order[k] = order[k + 1];
                order[k + 1] = swap;
            }
        }
    }
    bool is_good = true;
    for (int32_t layer = 0; layer + 1 < layers && is_good; ++layer) {
        int32_t at[3];
        for (int k = 0; k < 3; ++k) {
            at[k] = layer * stride + order[k];
        }
        for (int k = 0; k < 3; ++k) {
            is_good = is_good && solid_add_tetrahedron(s, at[0], at[1], at[2], at[k] + stride);
            at[k] += stride;
        }
    }
    return is_good;
}

/* The triangles between rings k and k + 1, whose first nodes are `inner` and `outer`. */
static bool zip(solid *s, const rings *r, int32_t k, int32_t stride, int32_t inner, int32_t outer)
{
    const int32_t m = r->size[k];
    const int32_t n = r->size[k + 1];
    bool is_good = true;
    for (int32_t i = 0, j = 0; (i < m || j < n) && is_good;) {
        /* A ring of one node has no steps of its own. */
        const bool steps_out =
            m == 1 ||
            (n > 1 && (i == m || (j < n && angle_of(r, k + 1, j + 1) < angle_of(r, k, i + 1))));
        if (steps_out) {
            is_good = add_prisms(s, stride, r->layer_count, inner + i % m, outer + j % n,
                                 outer + (j + 1) % n);
            ++j;
            i = m == 1 && j == n ? m : i;
        } else {
            is_good = add_prisms(s, stride, r->layer_count, inner + i % m, inner + (i + 1) % m,
                                 outer + j % n);
            ++i;
            j = n == 1 && i == m ? n : j;
        }
    }
    return is_good;
}

bool rings_fill(const rings *r, rings_place place, const void *body, solid *out)
{
    *out = (solid){0};
    bool is_good = true;
    for (int32_t layer = 0; layer < r->layer_count; ++layer) {
        for (int32_t k = 0; k < r->ring_count; ++k) {
            for (int32_t i = 0; i < r->size[k] && is_good; ++i) {
                double x[3];
                int32_t node;
                place(body, k, layer, angle_of(r, k, i), x);
                is_good = solid_add_node(out, x, &node);
            }
        }
    }
    const int32_t stride = (int32_t)rings_node_count(r);
    int32_t first = 0;
    for (int32_t k = 0; k + 1 < r->ring_count && is_good; ++k) {
        is_good = zip(out, r, k, stride, first, first + r->size[k]);
        first += r->size[k];
    }
    if (!is_good) {
        solid_fini(out);
    }
    return is_good;
}
