/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/papers/hybrid/reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- set-up ---- */

/* Volume and gradients by Cramer's rule. */
static double shape_slopes(const double *const p[4], double out[4][3])
{
    double e[3][3], determinant = 0.0;
    for (int k = 0; k < 3; ++k) {
        for (int a = 0; a < 3; ++a) {
            e[k][a] = p[k + 1][a] - p[0][a];
        }
    }
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        for (int k = 0; k < 3; ++k) {
            const double *f = e[(k + 1) % 3], *g = e[(k + 2) % 3];
            out[k + 1][a] = f[b] * g[c] - f[c] * g[b];
        }
        determinant += e[0][a] * out[1][a];
    }
    for (int a = 0; a < 3; ++a) {
        out[0][a] = 0.0;
        for (int k = 1; k < 4; ++k) {
            out[k][a] /= determinant;
            out[0][a] -= out[k][a];
        }
    }
    return fabs(determinant) / 6.0;
}

static void measure(ss_heart_reference *reference)
{
    const ss_mesh *mesh = reference->mesh;
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        const int32_t *c = mesh->tetrahedron[e];
        const double *const p[4] = {mesh->position[c[0]], mesh->position[c[1]],
                                    mesh->position[c[2]], mesh->position[c[3]]};
        reference->volume[e] = shape_slopes(p, reference->slope[e]);
        for (int k = 0; k < 4; ++k) {
            reference->mass[c[k]] += 0.25 * reference->volume[e];
        }
    }
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        double a[3], b[3];
        for (int k = 0; k < 3; ++k) {
            a[k] = mesh->position[c[1]][k] - mesh->position[c[0]][k];
            b[k] = mesh->position[c[2]][k] - mesh->position[c[0]][k];
        }
        const double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                             a[0] * b[1] - a[1] * b[0]};
        reference->area[t] = 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }
}

bool ss_heart_reference_init(ss_heart_reference *reference, const ss_mesh *mesh, double lambda,
                             double mu, const char *group)
{
    const size_t n = (size_t)mesh->node_count, elements = (size_t)mesh->tetrahedron_count;
    *reference = (ss_heart_reference){.mesh = mesh, .lambda = lambda, .mu = mu, .pushed = -1};
    reference->slope = calloc(elements, sizeof *reference->slope);
    reference->volume = calloc(elements, sizeof *reference->volume);
    reference->mass = calloc(n, sizeof *reference->mass);
    reference->area = calloc((size_t)mesh->triangle_count, sizeof *reference->area);
    reference->u = calloc(n, sizeof *reference->u);
    reference->v = calloc(n, sizeof *reference->v);
    reference->force = calloc(n, sizeof *reference->force);
    reference->is_held = calloc(n, 1);
    if (!reference->slope || !reference->volume || !reference->mass || !reference->area ||
        !reference->u || !reference->v || !reference->force || !reference->is_held) {
        ss_heart_reference_fini(reference);
        return false;
    }
    measure(reference);
    for (int32_t g = 0; g < mesh->group_count; ++g) {
        const ss_mesh_group *at = &mesh->group[g];
        for (int32_t k = 0; strcmp(at->name, group) == 0 && k < at->node_count; ++k) {
            reference->is_held[at->node[k]] = 1;
        }
    }
    return true;
}

void ss_heart_reference_fini(ss_heart_reference *reference)
{
    void *const parts[] = {reference->slope, reference->volume, reference->mass,
                           reference->area,  reference->u,      reference->v,
                           reference->force, reference->is_held};
    for (size_t k = 0; k < sizeof parts / sizeof *parts; ++k) {
        free(parts[k]);
    }
    *reference = (ss_heart_reference){.mesh = NULL};
}

/* ---- equations (1) to (6) ---- */

/* F - 1 and dF/dt of an element. */
static void gradients(const double slope[4][3], const double (*u)[3], const double (*v)[3],
                      const int32_t corner[4], double h[3][3], double rate[3][3])
{
    memset(h, 0, 9 * sizeof(double));
    memset(rate, 0, 9 * sizeof(double));
    for (int k = 0; k < 4; ++k) {
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                h[i][j] += u[corner[k]][i] * slope[k][j];
                rate[i][j] += v[corner[k]][i] * slope[k][j];
            }
        }
    }
}

/* The guard's share: -V dW/dF of (lambda + 2 mu)/2 (0.65 - J)^2, with dJ/dF the cofactors of F. */
static void add_guard(ss_heart_reference *reference, int32_t e, const double h[3][3])
{
    const double least = 0.65, stiffness = reference->lambda + 2.0 * reference->mu;
    const int32_t *corner = reference->mesh->tetrahedron[e];
    double f[3][3], cofactor[3][3], j = 0.0;
    for (int k = 0; k < 9; ++k) {
        f[k / 3][k % 3] = h[k / 3][k % 3] + (k / 3 == k % 3 ? 1.0 : 0.0);
    }
    for (int a = 0; a < 3; ++a) {
        const double *p = f[(a + 1) % 3], *q = f[(a + 2) % 3];
        for (int b = 0; b < 3; ++b) {
            cofactor[a][b] = p[(b + 1) % 3] * q[(b + 2) % 3] - p[(b + 2) % 3] * q[(b + 1) % 3];
        }
    }
    for (int b = 0; b < 3; ++b) {
        j += f[0][b] * cofactor[0][b];
    }
    if (j >= least) {
        return;
    }
    reference->elastic += 0.5 * reference->volume[e] * stiffness * (least - j) * (least - j);
    for (int k = 0; k < 4; ++k) {
        const double *slope = reference->slope[e][k];
        for (int i = 0; i < 3; ++i) {
            reference->force[corner[k]][i] +=
                reference->volume[e] * stiffness * (least - j) *
                (cofactor[i][0] * slope[0] + cofactor[i][1] * slope[1] + cofactor[i][2] * slope[2]);
        }
    }
}

/* Adds the forces of all elements for u and v; the energy. sigma = lambda tr eps + 2 mu eps with
 * eps = F^T F - 1 = H + H^T + H^T H, W = sigma:eps/8, and P = F (sigma + sigma_v)/2. */
static void add_forces(ss_heart_reference *reference, const double (*u)[3], const double (*v)[3])
{
    reference->elastic = 0.0;
    for (int32_t e = 0; e < reference->mesh->tetrahedron_count; ++e) {
        const int32_t *corner = reference->mesh->tetrahedron[e];
        const double(*slope)[3] = (const double(*)[3])reference->slope[e];
        double h[3][3], rate[3][3], eps[3][3], nu[3][3], stress[3][3], trace = 0.0, flow = 0.0;
        gradients(slope, u, v, corner, h, rate);
        if (reference->is_guarded) {
            add_guard(reference, e, (const double(*)[3])h);
        }
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                eps[i][j] = h[i][j] + h[j][i];
                nu[i][j] = rate[i][j] + rate[j][i];
                for (int k = 0; k < 3; ++k) {
                    eps[i][j] += h[k][i] * h[k][j];
                    nu[i][j] += h[k][i] * rate[k][j] + rate[k][i] * h[k][j];
                }
            }
            trace += eps[i][i];
            flow += nu[i][i];
        }
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                const double elastic =
                    2.0 * reference->mu * eps[i][j] + (i == j ? reference->lambda * trace : 0.0);
                reference->elastic += 0.125 * reference->volume[e] * elastic * eps[i][j];
                stress[i][j] = elastic + 2.0 * reference->psi * nu[i][j] +
                               (i == j ? reference->phi * flow : 0.0);
            }
        }
        for (int i = 0; i < 3; ++i) {
            double row[3];
            for (int j = 0; j < 3; ++j) {
                row[j] = stress[i][j];
                for (int k = 0; k < 3; ++k) {
                    row[j] += h[i][k] * stress[k][j];
                }
            }
            for (int k = 0; k < 4; ++k) {
                reference->force[corner[k]][i] -=
                    0.5 * reference->volume[e] *
                    (row[0] * slope[k][0] + row[1] * slope[k][1] + row[2] * slope[k][2]);
            }
        }
    }
}

/* A pressure of the depth of the ball at samples, 16 to a surface triangle at the centroids of its
 * quarters' quarters, along the way out of the ball. */
static void add_ball(ss_heart_reference *reference)
{
    enum { PARTS = 4 };
    const ss_mesh *mesh = reference->mesh;
    memset(reference->ball_force, 0, sizeof reference->ball_force);
    for (int32_t t = 0; reference->radius > 0.0 && t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        double p[3][3], middle[3] = {0.0, 0.0, 0.0}, reach = 0.0, off = 0.0;
        for (int k = 0; k < 9; ++k) {
            p[k / 3][k % 3] = mesh->position[c[k / 3]][k % 3] + reference->u[c[k / 3]][k % 3];
            middle[k % 3] += p[k / 3][k % 3] / 3.0;
        }
        for (int a = 0; a < 3; ++a) {
            reach = fmax(reach, fabs(p[0][a] - p[1][a]) + fabs(p[0][a] - p[2][a]));
            off = fmax(off, fabs(middle[a] - reference->ball[a]));
        }
        if (off > reference->radius + reach) {
            continue;
        }
        for (int s = 0; s < PARTS * PARTS; ++s) {
            /* Row s / 4 has upright parts and, between them, upside-down ones. */
            int row = 0, first = 0;
            while (s >= first + 2 * (PARTS - row) - 1) {
                first += 2 * (PARTS - row) - 1;
                ++row;
            }
            const int place = s - first;
            const double third = place % 2 == 0 ? 1.0 / 3.0 : 2.0 / 3.0;
            const double w1 = (place / 2 + third) / PARTS, w2 = (row + third) / PARTS;
            const double weight[3] = {1.0 - w1 - w2, w1, w2};
            double d[3], square = 0.0;
            for (int a = 0; a < 3; ++a) {
                d[a] = weight[0] * p[0][a] + weight[1] * p[1][a] + weight[2] * p[2][a] -
                       reference->ball[a];
                square += d[a] * d[a];
            }
            const double distance = sqrt(square), depth = reference->radius - distance;
            for (int a = 0; a < 3 && depth > 0.0; ++a) {
                const double push = reference->stiffness * reference->area[t] / (PARTS * PARTS) *
                                    depth * d[a] / distance;
                reference->ball_force[a] -= push;
                for (int k = 0; k < 3; ++k) {
                    reference->force[c[k]][a] += weight[k] * push;
                }
            }
        }
    }
}

void ss_heart_reference_run(ss_heart_reference *reference, int32_t steps, double dt)
{
    const size_t size = (size_t)reference->mesh->node_count * sizeof *reference->force;
    for (int32_t s = 0; s < steps; ++s) {
        memset(reference->force, 0, size);
        add_forces(reference, (const double(*)[3])reference->u, (const double(*)[3])reference->v);
        add_ball(reference);
        for (int k = 0; k < 3 && reference->pushed >= 0; ++k) {
            reference->force[reference->pushed][k] += reference->push[k];
        }
        reference->kinetic = 0.0;
        for (int32_t i = 0; i < reference->mesh->node_count; ++i) {
            for (int k = 0; k < 3 && !reference->is_held[i]; ++k) {
                reference->v[i][k] =
                    (reference->v[i][k] + dt * reference->force[i][k] / reference->mass[i]) /
                    (1.0 + dt * reference->damping);
                reference->u[i][k] += dt * reference->v[i][k];
                reference->kinetic +=
                    0.5 * reference->mass[i] * reference->v[i][k] * reference->v[i][k];
            }
        }
    }
}

void ss_heart_reference_move(ss_heart_reference *reference, const double to[3], int32_t steps,
                             double dt)
{
    double from[3];
    memcpy(from, reference->ball, sizeof from);
    for (int32_t k = 1; k <= steps; ++k) {
        for (int a = 0; a < 3; ++a) {
            reference->ball[a] = from[a] + (to[a] - from[a]) * k / steps;
        }
        ss_heart_reference_run(reference, 1, dt);
    }
}

bool ss_heart_reference_stable_step(ss_heart_reference *reference, double *out_step)
{
    enum { ROUNDS = 600 };
    static const double small = 1e-7; /* of a displacement, against the body's size of 1 */
    const int32_t n = reference->mesh->node_count;
    const double phi = reference->phi, psi = reference->psi;
    double(*mode)[3] = calloc((size_t)n, sizeof *mode), omega_square = 0.0;
    double(*still)[3] = calloc((size_t)n, sizeof *still);
    if (mode == NULL || still == NULL) {
        free(mode);
        free(still);
        return false;
    }
    reference->phi = reference->psi = 0.0;
    for (int32_t i = 0; i < 3 * n; ++i) {
        mode[i / 3][i % 3] = reference->is_held[i / 3] ? 0.0 : small * sin(12.9898 * i + 1.0);
    }
    for (int round = 0; round < ROUNDS; ++round) {
        double square = 0.0, product = 0.0;
        memset(reference->force, 0, (size_t)n * sizeof *reference->force);
        add_forces(reference, (const double(*)[3])mode, (const double(*)[3])still);
        for (int32_t i = 0; i < n; ++i) {
            for (int k = 0; k < 3; ++k) {
                square += reference->mass[i] * mode[i][k] * mode[i][k];
                product -= reference->is_held[i] ? 0.0 : mode[i][k] * reference->force[i][k];
            }
        }
        omega_square = product / square; /* Rayleigh's quotient */
        double most = 0.0;
        for (int32_t i = 0; i < n; ++i) {
            for (int k = 0; k < 3; ++k) {
                mode[i][k] =
                    reference->is_held[i] ? 0.0 : -reference->force[i][k] / reference->mass[i];
                most = fmax(most, fabs(mode[i][k]));
            }
        }
        for (int32_t i = 0; i < n; ++i) {
            for (int k = 0; k < 3; ++k) {
                mode[i][k] *= small / most;
            }
        }
    }
    reference->phi = phi;
    reference->psi = psi;
    free(mode);
    free(still);
    *out_step = 2.0 / sqrt(omega_square);
    return true;
}
