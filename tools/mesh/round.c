/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "round.h"

#include "mesh/tetrahedron.h"
#include "shape.h"

/* Of the size: ends nearer to a surface lie on it. */
#define NEAR_SURFACE 1e-6
/* As fem-quadratic has it: below this share of an element's mean Jacobian it is straight. */
#define LEAST_JACOBIAN 0.2
enum { PROJECTION_STEPS = 6 };

static const int ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/* 1 on the ellipsoid, or where an axis is 0 on the cylinder along it. */
static double place_of(const double x[3], const double axes[3])
{
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        sum += axes[k] > 0.0 ? x[k] * x[k] / (axes[k] * axes[k]) : 0.0;
    }
    return sqrt(sum);
}

static bool are_on(const double a[3], const double b[3], const double axes[3])
{
    return fabs(place_of(a, axes) - 1.0) < NEAR_SURFACE &&
           fabs(place_of(b, axes) - 1.0) < NEAR_SURFACE;
}

/* x towards or off the middle of the axes that are not 0. */
static void scale_to(double x[3], const double axes[3], double place)
{
    const double factor = place / place_of(x, axes);
    for (int k = 0; k < 3; ++k) {
        x[k] *= axes[k] > 0.0 ? factor : 1.0;
    }
}

/* A shell's ellipsoid; at a ventricle's base the ellipse in which it ends. */
static void pull_to_shell(const volume_plan *plan, const double full[3], const double a[3],
                          const double b[3], double x[3])
{
    const double axes[3] = {0.5 * full[0], 0.5 * full[1], 0.5 * full[2]};
    const double near = NEAR_SURFACE * axes[2];
    if (!are_on(a, b, axes)) {
        return;
    }
    if (plan->kind == VOLUME_VENTRICLE && fabs(a[2] - plan->base) < near &&
        fabs(b[2] - plan->base) < near) {
        const double flat[3] = {axes[0], axes[1], 0.0}, z = x[2] / axes[2];
        scale_to(x, flat, sqrt(1.0 - z * z));
    } else {
        scale_to(x, axes, 1.0);
    }
}

/* The middle x of a side a b of the surface. */
static void pull(const volume_plan *plan, const organ *o, const double a[3], const double b[3],
                 double x[3])
{
    const double round[3] = {0.5 * plan->size[0], 0.5 * plan->size[1], 0.0};
    switch (plan->kind) {
    case VOLUME_KIDNEY:
    case VOLUME_LIVER:
    case VOLUME_ELLIPSOID:
        organ_project(o, x, PROJECTION_STEPS);
        break;
    case VOLUME_CYLINDER:
        if (are_on(a, b, round)) {
            scale_to(x, round, 1.0);
        }
        break;
    case VOLUME_VENTRICLE:
    case VOLUME_ELLIPSOIDS:
        pull_to_shell(plan, plan->size, a, b, x);
        pull_to_shell(plan, plan->inner, a, b, x);
        break;
    default:
        break;
    }
}

/* Straightens the sides of elements bent too far; true where there was one. */
static bool straighten(ss_mesh *mesh)
{
    bool is_any = false;
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        int32_t node[SS_TETRAHEDRON_NODES];
        double least = (double)INFINITY, mean = 0.0;
        for (int k = 0; k < SS_TETRAHEDRON_NODES; ++k) {
            node[k] = k < 4 ? mesh->tetrahedron[e][k] : mesh->middle[e][k - 4];
        }
        for (int q = 0; q < SS_TETRAHEDRON_POINTS; ++q) {
            double unused[4][3];
            const double volume =
                ss_tetrahedron_point((const double(*)[3])mesh->position, node, q, unused);
            least = fmin(least, volume);
            mean += volume / SS_TETRAHEDRON_POINTS;
        }
        for (int s = 0; least < LEAST_JACOBIAN * mean && s < 6; ++s) {
            double x[3];
            ss_add3(x, mesh->position[node[ends[s][0]]], mesh->position[node[ends[s][1]]]);
            ss_scale3(x, x, 0.5);
            for (int i = 0; i < 3; ++i) {
                is_any = is_any || x[i] != mesh->position[node[4 + s]][i];
            }
            ss_copy3(mesh->position[node[4 + s]], x);
        }
    }
    return is_any;
}

void round_middles(const volume_plan *plan, ss_mesh *mesh)
{
    static const organ_kind organs[] = {[VOLUME_KIDNEY] = ORGAN_KIDNEY,
                                        [VOLUME_LIVER] = ORGAN_LIVER,
                                        [VOLUME_ELLIPSOID] = ORGAN_ELLIPSOID};
    organ o = {0};
    if (plan->kind <= VOLUME_ELLIPSOID) {
        const double half[3] = {0.5 * plan->size[0], 0.5 * plan->size[1], 0.5 * plan->size[2]};
        organ_init(&o, organs[plan->kind], half);
    }
    for (int32_t f = 0; f < mesh->triangle_count; f += 4) {
        const int32_t(*four)[3] = (const int32_t(*)[3])mesh->triangle + f;
        for (int k = 0; k < 3; ++k) {
            const double *a = mesh->position[four[k][0]], *b = mesh->position[four[(k + 1) % 3][0]];
            double *x = mesh->position[four[3][k]];
            ss_add3(x, a, b);
            ss_scale3(x, x, 0.5);
            pull(plan, &o, a, b, x);
        }
    }
    while (straighten(mesh)) {
        /* Neighbours share the sides. */
    }
}
