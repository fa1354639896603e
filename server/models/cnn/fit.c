/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * Free bodies: where the rest shape lies now, P* = R P0 + t.
 *
 * R and t are the best rigid fit of the present positions (weights ks), recomputed at every
 * evaluation, without memory. At the fit the energy of the rest springs does not change with R
 * and t, so that ks (P - P*) is still the gradient, and neither a net force nor a torque is left.
 * R is the unit quaternion that belongs to the largest eigenvalue of Horn's 4 x 4 matrix (1987),
 * by a fixed number of Jacobi sweeps. Rejected: a fit that starts from the last rotation, which
 * would be state.
 */
#include <math.h>
#include <string.h>

#include "rt/vec.h"

/* Eigenvector of the largest eigenvalue of a symmetric 4 x 4 matrix, by Jacobi rotations. */
static void largest_eigenvector(double a[4][4], double out[4])
{
    enum { SWEEPS = 12 };
    double q[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (int sweep = 0; sweep < SWEEPS; ++sweep) {
        for (int p = 0; p < 3; ++p) {
            for (int r = p + 1; r < 4; ++r) {
                if (!(fabs(a[p][r]) > 0.0)) {
                    continue;
                }
                const double theta = 0.5 * (a[r][r] - a[p][p]) / a[p][r];
                const double t =
                    (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
                const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
                for (int k = 0; k < 4; ++k) {
                    ss_rotate_pair(&a[k][p], &a[k][r], c, s);
                }
                for (int k = 0; k < 4; ++k) {
                    ss_rotate_pair(&a[p][k], &a[r][k], c, s);
                    ss_rotate_pair(&q[k][p], &q[k][r], c, s);
                }
            }
        }
    }
    int best = 0;
    for (int k = 1; k < 4; ++k) {
        best = a[k][k] > a[best][best] ? k : best;
    }
    for (int k = 0; k < 4; ++k) {
        out[k] = q[k][best];
    }
}

/* The rotation that best turns rest into present: Horn 1987, from the weighted covariance
 * s[a][b] = sum w (present_a)(rest_b). */
static void best_rotation(double s[3][3], double out[3][3])
{
    double m[4][4] = {
        {s[0][0] + s[1][1] + s[2][2], s[2][1] - s[1][2], s[0][2] - s[2][0], s[1][0] - s[0][1]},
        {s[2][1] - s[1][2], s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
        {s[0][2] - s[2][0], s[0][1] + s[1][0], s[1][1] - s[0][0] - s[2][2], s[1][2] + s[2][1]},
        {s[1][0] - s[0][1], s[2][0] + s[0][2], s[1][2] + s[2][1], s[2][2] - s[0][0] - s[1][1]}};
    double q[4];
    largest_eigenvector(m, q);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double r[3][3] = {
        {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
        {2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)},
        {2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)}};
    memcpy(out, r, sizeof r);
}

/* Weight of a node in the fit: ks, or size where the body has no rest stiffness at all. */
static double fit_weight(const ss_model *model, int32_t i)
{
    return model->fit_weight > 0.0 ? model->material.rest_stiffness[i] : model->network->size[i];
}

const ss_real *ss_cnn_fit(ss_model *model, const ss_real *u)
{
    if (model->is_held) {
        return u;
    }
    const double(*rest)[3] = (const double(*)[3])model->plan.mesh->position;
    double sum = 0.0, mean[3] = {0.0}, s[3][3] = {{0.0}};
    for (int32_t i = 0; i < model->node_count; ++i) {
        const double w = fit_weight(model, i);
        sum += w;
        for (int k = 0; k < 3; ++k) {
            mean[k] += w * (double)u[4 * (ptrdiff_t)i + k];
        }
    }
    ss_scale3(mean, mean, 1.0 / sum);
    for (int32_t i = 0; i < model->node_count; ++i) {
        const double w = fit_weight(model, i);
        double q[3], p[3];
        ss_sub3(q, rest[i], model->centroid_rest);
        for (int k = 0; k < 3; ++k) {
            p[k] = q[k] + (double)u[4 * (ptrdiff_t)i + k] - mean[k];
        }
        for (int a = 0; a < 3; ++a) {
            ss_madd3(s[a], s[a], w * p[a], q);
        }
    }
    best_rotation(s, model->rotation);
    for (int32_t i = 0; i < model->node_count; ++i) {
        double q[3];
        ss_sub3(q, rest[i], model->centroid_rest);
        for (int k = 0; k < 3; ++k) {
            const double turned = ss_dot3(model->rotation[k], q);
            model->fitted[4 * (ptrdiff_t)i + k] =
                (ss_real)((double)u[4 * (ptrdiff_t)i + k] - mean[k] - (turned - q[k]));
        }
    }
    return model->fitted;
}
