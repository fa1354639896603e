/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * Saturation where several sources act at once.
 *
 * A cell's output is |y| <= K (Zhong, Shirinzadeh, Alici, Smith 2006, equation 1). One source of
 * strength I raises its own cells to G I and therefore acts with X = min(I, K / G). With several,
 * each raises the others' cells too: with G_kl the mean potential at the cells of source k for a
 * source l of 1 J, the strengths that act must keep G X <= K. Each would be I_k = E^_k eps_k+.
 *
 * The force must stay the gradient of one convex potential of the strains. Its conjugate says how:
 * the energy of strengths is sum X^2 / (2 E^) where they are allowed and infinite elsewhere, so
 *
 *   Psi(eps) = max { X.eps - sum_k X_k^2 / (2 E^_k) :  X >= 0, G X <= K }
 *
 * is convex as a maximum of linear functions, and by the envelope theorem dPsi/deps_k = X_k with
 *
 *   X = argmin { sum_k (X_k - I_k)^2 / E^_k :  X >= 0, G X <= K },
 *
 * the projection of I in the metric of the stored energy. Its conditions are, with E^ = diag(E^_k),
 *
 *   X = I - E^ (G' mu - nu),   0 <= mu _|_ K - G X >= 0,   0 <= nu _|_ X >= 0,
 *
 * a linear complementarity problem with the matrix A E^ A', A = (G; -1), symmetric and positive
 * semidefinite. One source gives min(I, K / G) again; the stretch that acts is X / E^. Since X is
 * the projection, dX/deps is symmetric and at most E^: E^ stands for it in the step bound.
 *
 * Rejected: the literal clip, which takes current from saturated cells only. With two sources of
 * which the first saturates, X_1 = (K - G_12 I_2) / G_11 and X_2 = I_2: dX_1/deps_2 < 0 while
 * dX_2/deps_1 = 0, so that X is the gradient of nothing, and stretching one, then the other, and
 * back in the same order gains energy on every round. For *given* currents the clip is right, and
 * is the obstacle problem below, on which the network of equations (1) and (2) settles whatever
 * R_x is; here the currents answer the strains.
 *
 * The weights of tools move with the tissue; a tool keeps its own rule (source.c).
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

enum { MAX_SOURCES = SS_CNN_MAX_SATURATED };
/* Of the problem's size: how far a condition may be violated, and pivots that count as zero. */
#define TOLERANCE 1e-13
#define NO_PIVOT  1e-12
/* Of K: by how much what was found may be beyond it and still count as solved. */
#define EXCESS 1e-9
/* Wishes over K beyond which doubles hold no digit of what may act; and beyond which it is nothing.
 */
#define BLIND_OVER 1e12
#define MAX_OVER   1e150
/* Conditions taken up in one solve; a problem takes about as many as it has sources. */
enum { MAX_ROUNDS = 256 };

/* ---- the complementarity problem ---- */

/* x := M_AA^-1 x over the `count` conditions in `active`, by Cholesky's factor. */
static void solve_active(int32_t n, const double *matrix, int32_t count, const int32_t *active,
                         double *x)
{
    double factor[SS_CNN_LCP_MAX][SS_CNN_LCP_MAX];
    for (int32_t i = 0; i < count; ++i) {
        for (int32_t j = 0; j <= i; ++j) {
            double sum = matrix[active[i] * n + active[j]];
            for (int32_t k = 0; k < j; ++k) {
                sum -= factor[i][k] * factor[j][k];
            }
            factor[i][j] = i == j ? sqrt(sum) : sum / factor[j][j];
        }
    }
    ss_solve_cholesky(count, factor[0], SS_CNN_LCP_MAX, x);
}

static double residual_at(int32_t n, const double *matrix, const double *q, const double *z,
                          int32_t row)
{
    double sum = q[row];
    for (int32_t k = 0; k < n; ++k) {
        sum += matrix[row * n + k] * z[k];
    }
    return sum;
}

/* Raises z_p until w_p = 0, with w = 0 kept on `active`; conditions whose multiplier falls to 0 on
 * the way leave. False where no such z exists. */
static bool take_up(int32_t n, const double *matrix, const double *q, int32_t p, double *z,
                    int32_t *active, int32_t *count)
{
    for (int32_t left = *count; left >= 0; --left) {
        double fall[SS_CNN_LCP_MAX] = {0.0}, slope = matrix[p * n + p];
        for (int32_t i = 0; i < *count; ++i) {
            fall[i] = matrix[active[i] * n + p];
        }
        solve_active(n, matrix, *count, active, fall);
        int32_t first = -1;
        double limit = (double)INFINITY;
        for (int32_t i = 0; i < *count; ++i) {
            slope -= matrix[p * n + active[i]] * fall[i];
            if (fall[i] > 0.0 && z[active[i]] < limit * fall[i]) {
                limit = z[active[i]] / fall[i];
                first = i;
            }
        }
        const bool is_independent = slope > NO_PIVOT * matrix[p * n + p];
        const double whole =
            is_independent ? -residual_at(n, matrix, q, z, p) / slope : (double)INFINITY;
        const double step = fmin(whole, limit);
        if (!isfinite(step)) {
            return false;
        }
        for (int32_t i = 0; i < *count; ++i) {
            z[active[i]] -= step * fall[i];
        }
        z[p] += step;
        if (whole <= limit) {
            active[(*count)++] = p;
            return true;
        }
        z[active[first]] = 0.0;
        active[first] = active[--*count];
    }
    return false;
}

bool ss_cnn_lcp(int32_t n, const double *matrix, const double *q, double *out_z)
{
    int32_t active[SS_CNN_LCP_MAX], count = 0;
    double size = 1.0;
    memset(out_z, 0, (size_t)n * sizeof *out_z);
    for (int32_t row = 0; row < n; ++row) {
        size = fmax(size, fabs(q[row]));
    }
    for (int round = 0; round < MAX_ROUNDS; ++round) {
        int32_t worst = -1;
        double least = -TOLERANCE * size;
        for (int32_t row = 0; row < n; ++row) {
            const double w = residual_at(n, matrix, q, out_z, row);
            if (!(out_z[row] > 0.0) && w < least) {
                worst = row;
                least = w;
            }
        }
        if (worst < 0) {
            return true;
        }
        for (int32_t i = 0; i < count; ++i) { /* a multiplier that is 0 holds nothing */
            if (active[i] == worst) {
                active[i] = active[--count];
            }
        }
        if (!take_up(n, matrix, q, worst, out_z, active, &count)) {
            return false;
        }
    }
    return false;
}

/* out := G x */
static void find_outputs(int32_t count, const double row[MAX_SOURCES][MAX_SOURCES], const double *x,
                         double *out)
{
    for (int32_t k = 0; k < count; ++k) {
        out[k] = 0.0;
        for (int32_t l = 0; l < count; ++l) {
            out[k] += row[k][l] * x[l];
        }
    }
}

/* Matrix (zero so far) and right-hand side of the conditions: G X <= K first, then X >= 0. */
static void fill_conditions(int32_t count, const double row[MAX_SOURCES][MAX_SOURCES],
                            const double *metric, const double *wish, double *matrix, double *q)
{
    const int32_t n = 2 * count;
    find_outputs(count, row, wish, q);
    for (int32_t k = 0; k < count; ++k) {
        q[k] = 1.0 - q[k];
        q[count + k] = wish[k];
        for (int32_t l = 0; l < count; ++l) {
            for (int32_t j = 0; j < count; ++j) {
                matrix[k * n + l] += row[k][j] * metric[j] * row[l][j];
            }
            matrix[k * n + count + l] = matrix[(count + l) * n + k] = -row[k][l] * metric[l];
        }
        matrix[(count + k) * n + count + k] = metric[k];
    }
}

bool ss_cnn_project(int32_t count, const double *metric, const double *potential, double limit,
                    const double *wish, double *out_strength, int32_t *out_bound)
{
    double matrix[SS_CNN_LCP_MAX * SS_CNN_LCP_MAX] = {0.0}, q[SS_CNN_LCP_MAX] = {0.0};
    double row[MAX_SOURCES][MAX_SOURCES] = {{0.0}}, output[MAX_SOURCES], z[SS_CNN_LCP_MAX];
    double ease[MAX_SOURCES] = {0.0}, aim[MAX_SOURCES] = {0.0}, most = 0.0, stiffest = 0.0,
           over = 1.0;
    for (int32_t k = 0; k < count; ++k) {
        most = fmax(most, wish[k]);
        stiffest = fmax(stiffest, metric[k]);
    }
    for (int32_t k = 0; k < count; ++k) {
        double sum = 0.0;
        for (int32_t l = 0; l < count; ++l) {
            sum += potential[k * count + l] * wish[l];
        }
        over = fmax(over, sum / limit);
    }
    *out_bound = 0;
    if (over > MAX_OVER) {
        memset(out_strength, 0, (size_t)count * sizeof *out_strength);
        return false;
    }
    /* In units of K, the largest metric and the largest wish as far as K lets it act: what is found
     * is then of order 1, however far the wishes are beyond it. */
    const double unit = most / over;
    for (int32_t k = 0; k < count; ++k) {
        ease[k] = metric[k] / stiffest;
        aim[k] = wish[k] / unit;
        for (int32_t l = 0; l < count; ++l) {
            row[k][l] = potential[k * count + l] * (unit / limit);
        }
    }
    fill_conditions(count, (const double(*)[MAX_SOURCES])row, ease, aim, matrix, q);
    const bool is_solved = ss_cnn_lcp(2 * count, matrix, q, z);
    for (int32_t k = 0; k < count; ++k) {
        double pressed = -z[count + k];
        for (int32_t l = 0; l < count; ++l) {
            pressed += row[l][k] * z[l];
        }
        *out_bound += (z[k] > 0.0) + (z[count + k] > 0.0);
        out_strength[k] = z[count + k] > 0.0 ? 0.0 : fmax(aim[k] - ease[k] * pressed, 0.0);
    }
    /* Far beyond K the digits of what may act run out: K holds all the same. */
    double highest = 0.0;
    find_outputs(count, (const double(*)[MAX_SOURCES])row, out_strength, output);
    for (int32_t k = 0; k < count; ++k) {
        highest = fmax(highest, output[k]);
    }
    for (int32_t k = 0; k < count; ++k) {
        out_strength[k] *= unit / fmax(highest, 1.0);
    }
    return is_solved && over < BLIND_OVER && highest <= 1.0 + EXCESS;
}

/* ---- sources of the model ---- */

/* Mean potential at the cells of every source for source `l` of 1 J. */
static softsim_status set_potentials(ss_model *model, int32_t l, double *scale, double *field)
{
    const ss_cnn_source *from = &model->source[l];
    for (int32_t i = 0; i < from->cell_count; ++i) {
        scale[i] = from->cell_weight[i] / model->network->qhat[from->cell[i]];
    }
    const softsim_status status =
        ss_cnn_network_potential(model->network, from->cell_count, from->cell, scale, field);
    for (int32_t k = 0; status == SOFTSIM_OK && k < model->source_count; ++k) {
        const ss_cnn_source *to = &model->source[k];
        double mean = 0.0;
        for (int32_t i = 0; i < to->cell_count; ++i) {
            mean += to->cell_weight[i] * field[to->cell[i]];
        }
        model->saturation->potential[k][l] = mean;
    }
    return status;
}

softsim_status ss_cnn_saturation_create(ss_model *model, softsim_error *error)
{
    if (!isfinite(model->material.saturation) || model->source_count < 2) {
        return SOFTSIM_OK; /* one source has its limit in closed form */
    }
    if (model->source_count > MAX_SOURCES) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "cnn-energy: with saturation, loads and prescribed sets may act on at "
                          "most %d different sets of cells, and here are %d: combine them, or "
                          "leave saturation out",
                          MAX_SOURCES, model->source_count);
        return SOFTSIM_ERROR_SCENE;
    }
    double *scale = ss_memory_get((size_t)model->node_count, sizeof *scale);
    double *field = ss_memory_get((size_t)model->node_count, sizeof *field);
    model->saturation = ss_arena_get(&model->arena, 1, sizeof *model->saturation);
    softsim_status status = scale && field && model->saturation ? SOFTSIM_OK : SOFTSIM_ERROR_MEMORY;
    for (int32_t l = 0; status == SOFTSIM_OK && l < model->source_count; ++l) {
        status = set_potentials(model, l, scale, field);
    }
    ss_memory_free(scale);
    ss_memory_free(field);
    return status;
}

void ss_cnn_saturate(ss_model *model)
{
    const double limit = model->material.saturation;
    double metric[MAX_SOURCES], wish[MAX_SOURCES], strength[MAX_SOURCES];
    double potential[MAX_SOURCES * MAX_SOURCES], highest = 0.0;
    int32_t list[MAX_SOURCES], count = 0, bound = 0;
    for (int32_t k = 0; k < model->source_count; ++k) {
        const ss_cnn_source *source = &model->source[k];
        if (source->is_on) {
            list[count] = k;
            metric[count] = source->modulus;
            wish[count++] = source->modulus * fmax(source->eps, 0.0);
        }
    }
    for (int32_t k = 0; k < count; ++k) {
        double sum = 0.0;
        for (int32_t l = 0; l < count; ++l) {
            potential[k * count + l] = model->saturation->potential[list[k]][list[l]];
            sum += potential[k * count + l] * wish[l];
        }
        highest = fmax(highest, sum);
    }
    if (count < 2 || !(highest > limit) || !isfinite(highest)) {
        return; /* each one's own rule, taken already */
    }
    const bool is_solved = ss_cnn_project(count, metric, potential, limit, wish, strength, &bound);
    if (!is_solved && model->verdict == SOFTSIM_VERDICT_GOOD) {
        model->verdict = SOFTSIM_VERDICT_GUARDED;
        model->reason = "saturation of several sources was not solved to rounding";
    }
    for (int32_t k = 0; k < count; ++k) {
        ss_cnn_source_set_stretch(model, &model->source[list[k]], strength[k] / metric[k],
                                  strength[k] > 0.0 && bound < count);
    }
}

/* ---- for given currents ---- */

softsim_status ss_cnn_obstacle(ss_cnn_network *network, int32_t count, const int32_t *node,
                               const double *current, double saturation, double *out_potential)
{
    /* With the symmetric Green's function g_ij = ghat_j(i) rho_j / S_j and s = S I / rho:
     * 0 <= z _|_ K - g (s - z) >= 0, in units of K and of the largest s. */
    double matrix[SS_CNN_LCP_MAX * SS_CNN_LCP_MAX], q[SS_CNN_LCP_MAX], z[SS_CNN_LCP_MAX];
    double flow[SS_CNN_LCP_MAX], scale[SS_CNN_LCP_MAX], most = 0.0;
    if (count < 1 || count > SS_CNN_LCP_MAX || !(saturation > 0.0)) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    for (int32_t j = 0; j < count; ++j) {
        flow[j] = network->size[node[j]] / network->factor->rho[node[j]];
        most = fmax(most, flow[j] * current[j]);
    }
    for (int32_t j = 0; j < count; ++j) {
        const double one = most / (flow[j] * saturation);
        const softsim_status status =
            ss_cnn_network_potential(network, 1, &node[j], &one, out_potential);
        if (status != SOFTSIM_OK) {
            return status;
        }
        for (int32_t i = 0; i < count; ++i) {
            matrix[i * count + j] = out_potential[node[i]];
        }
    }
    for (int32_t i = 0; i < count; ++i) {
        q[i] = 1.0;
        for (int32_t j = 0; j < count; ++j) {
            q[i] -= matrix[i * count + j] * flow[j] * current[j] / most;
        }
    }
    if (most > 0.0 && !ss_cnn_lcp(count, matrix, q, z)) {
        return SOFTSIM_ERROR_ARGUMENT;
    }
    for (int32_t j = 0; j < count; ++j) {
        scale[j] = most > 0.0 ? current[j] - most * z[j] / flow[j] : 0.0;
    }
    return ss_cnn_network_potential(network, count, node, scale, out_potential);
}
