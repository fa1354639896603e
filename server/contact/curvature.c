/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Normals and curvature of the rest surface, per node: per fan, where a body touches itself in one.
 *
 * S is the Hessian of the surface's height along its outward normal n: n(x + D) = n - S D, so
 * S < 0 on a convex body (-1/rho on a ball). At node i it is the symmetric 2 x 2 fit, by least
 * squares over the ring, of n_j - n_i = -S (x_j - x_i) in the tangent plane, n_i the area-weighted
 * node normals; then averaged once over the triangles around the node. Rejected: dihedral angles
 * (noise of the mesh's facets), derivatives of the Loop surface (jumps at extraordinary nodes).
 */
#include <math.h>

#include "contact/surface.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* Normal equations of one node: unknowns Sxx Sxy Syy in its tangent basis. */
typedef struct fit {
    double m[6]; /* 00 01 02 11 12 22 */
    double b[3];
    double first[3], second[3]; /* basis */
} fit;

static void set_basis(const ss_real normal[3], fit *f)
{
    double n[3];
    double axis[3] = {0.0, 0.0, 0.0};
    int least = 0;
    for (int k = 0; k < 3; ++k) {
        n[k] = (double)normal[k];
        least = fabs(n[k]) < fabs(n[least]) ? k : least;
    }
    axis[least] = 1.0;
    ss_cross3(f->first, n, axis);
    ss_normalize3(f->first);
    ss_cross3(f->second, n, f->first);
}

static void add_neighbour(fit *f, const double edge[3], const double turn[3])
{
    const double x = ss_dot3(edge, f->first);
    const double y = ss_dot3(edge, f->second);
    const double tx = -ss_dot3(turn, f->first);
    const double ty = -ss_dot3(turn, f->second);
    f->m[0] += x * x;
    f->m[1] += x * y;
    f->m[3] += x * x + y * y;
    f->m[4] += x * y;
    f->m[5] += y * y;
    f->b[0] += tx * x;
    f->b[1] += tx * y + ty * x;
    f->b[2] += ty * y;
}

/* Solves by Cholesky, a little of the trace added so that a degenerate ring is flat. */
static void solve_fit(const fit *f, ss_real out[6])
{
    const double extra = 1e-6 * (f->m[0] + f->m[3] + f->m[5]);
    for (int k = 0; k < 6; ++k) {
        out[k] = 0;
    }
    if (!(extra > 0.0)) {
        return;
    }
    const double l00 = sqrt(f->m[0] + extra);
    const double l10 = f->m[1] / l00;
    const double l20 = f->m[2] / l00;
    const double l11 = sqrt(f->m[3] + extra - l10 * l10);
    const double l21 = (f->m[4] - l20 * l10) / l11;
    const double l22 = sqrt(f->m[5] + extra - l20 * l20 - l21 * l21);
    const double y0 = f->b[0] / l00;
    const double y1 = (f->b[1] - l10 * y0) / l11;
    const double y2 = (f->b[2] - l20 * y0 - l21 * y1) / l22;
    const double yy = y2 / l22;
    const double xy = (y1 - l21 * yy) / l11;
    const double xx = (y0 - l10 * xy - l20 * yy) / l00;
    if (!isfinite(xx) || !isfinite(xy) || !isfinite(yy)) {
        return;
    }
    int k = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
            out[k++] = (ss_real)(xx * f->first[i] * f->first[j] + yy * f->second[i] * f->second[j] +
                                 xy * (f->first[i] * f->second[j] + f->second[i] * f->first[j]));
        }
    }
}

static void set_normals(ss_surface *surface, const ss_mesh *mesh, const ss_edges *edges)
{
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *v = mesh->triangle[t];
        double area[3];
        ss_normal3(area, mesh->position[v[0]], mesh->position[v[1]], mesh->position[v[2]]);
        for (int k = 0; k < 9; ++k) {
            surface->fan_normal[edges->fan[3 * t + k / 3]][k % 3] += (ss_real)area[k % 3];
        }
    }
    for (int32_t i = 0; i < edges->fan_count; ++i) {
        ss_real *n = surface->fan_normal[i];
        double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
        if (!(ss_normalize3(normal) > 0.0)) {
            ss_set3(normal, 0.0, 0.0, 1.0);
        }
        for (int k = 0; k < 3; ++k) {
            n[k] = (ss_real)normal[k];
        }
    }
}

static void fit_fans(const ss_surface *surface, const ss_mesh *mesh, const ss_edges *edges,
                     fit *fits)
{
    for (int32_t i = 0; i < edges->fan_count; ++i) {
        set_basis(surface->fan_normal[i], &fits[i]);
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        for (int k = 0; k < 6; ++k) {
            const int from = k % 3, to = (k % 3 + 1 + k / 3) % 3;
            const int32_t i = edges->fan[3 * t + from];
            const int32_t j = edges->fan[3 * t + to];
            double edge[3], turn[3];
            ss_sub3(edge, mesh->position[mesh->triangle[t][to]],
                    mesh->position[mesh->triangle[t][from]]);
            for (int c = 0; c < 3; ++c) {
                turn[c] = (double)surface->fan_normal[j][c] - (double)surface->fan_normal[i][c];
            }
            add_neighbour(&fits[i], edge, turn);
        }
    }
}

softsim_status ss_surface_curve(ss_surface *surface, const ss_mesh *mesh, const ss_edges *edges)
{
    const size_t fans = (size_t)edges->fan_count;
    fit *fits = ss_memory_get(fans, sizeof(fit));
    ss_real(*rough)[6] = ss_memory_get(fans, sizeof *rough);
    int32_t *count = ss_memory_get(fans, sizeof(int32_t));
    surface->fan_normal = ss_memory_get(fans, sizeof *surface->fan_normal);
    surface->fan_curvature = ss_memory_get(fans, sizeof *surface->fan_curvature);
    const bool is_good = fits != NULL && rough != NULL && count != NULL &&
                         surface->fan_normal != NULL && surface->fan_curvature != NULL;
    if (is_good) {
        set_normals(surface, mesh, edges);
        fit_fans(surface, mesh, edges, fits);
        for (size_t i = 0; i < fans; ++i) {
            solve_fit(&fits[i], rough[i]);
        }
        for (int32_t t = 0; t < mesh->triangle_count; ++t) {
            const int32_t *v = &edges->fan[3 * t];
            for (int k = 0; k < 3; ++k) {
                for (int c = 0; c < 6; ++c) {
                    surface->fan_curvature[v[k]][c] +=
                        (rough[v[0]][c] + rough[v[1]][c] + rough[v[2]][c]) / 3;
                }
                count[v[k]]++;
            }
        }
        for (size_t i = 0; i < fans; ++i) {
            for (int c = 0; c < 6; ++c) {
                surface->fan_curvature[i][c] /= (ss_real)count[i];
            }
        }
    }
    SS_EACH(ss_memory_free, count, rough, fits);
    return is_good ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
}
