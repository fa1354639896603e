/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What a closed body encloses resists compression as a whole. Of each body k of the mesh (a part
 * connected by triangles or tetrahedra, its cavities included)
 *
 *   Psi_k = (B / 2 V_k) (sum N_i.u_i)^2        N_i: a third of the area vectors of i's triangles
 *   p_k   = (B / V_k) sum N_i.u_i              force -p_k N_i, sums over the nodes of body k
 *
 * A body of its own has a volume of its own: pressing one leaves the other still. The bodies share
 * no node, so that their rank-one terms (B/V_k) N N' do not meet: the step bound takes the largest
 * of (B/V_k) sum |N_i|^2/m_i, not their sum.
 *
 * One body, the usual case, is left to the stage kernel, which has u at hand. Several take a pass
 * over the nodes at every evaluation, their pressures in model->force.
 * Rejected: one volume for the whole mesh (pressing one kidney of two by 2.4 mm blew the other up
 * by 0.4 mm); an array of N a body with zeros elsewhere (memory and time of bodies times nodes).
 */
#include "models/cnn/cnn.h"

#include <math.h>

#include "rt/memory.h"
#include "rt/vec.h"

static int32_t body_of(const ss_model *model, int32_t node)
{
    return model->body ? model->body[node] : 0;
}

/* ---- set-up ---- */

static softsim_status find_bodies(ss_model *model)
{
    const ss_mesh *mesh = model->plan.mesh;
    model->body = ss_arena_get(&model->arena, (size_t)model->node_count, sizeof *model->body);
    model->enclosed_count = model->body ? ss_mesh_find_bodies(mesh, model->body) : -1;
    if (model->enclosed_count < 0) {
        model->enclosed_count = 0;
        return SOFTSIM_ERROR_MEMORY;
    }
    if (model->enclosed_count == 1) {
        model->body = NULL;
    }
    const size_t count = (size_t)model->enclosed_count;
    model->enclosed = ss_arena_get(&model->arena, count, sizeof *model->enclosed);
    return ss_arena_status(&model->arena);
}

/* N_i and V_k. */
static void set_volumes(ss_model *model)
{
    const ss_mesh *mesh = model->plan.mesh;
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        const int32_t *c = mesh->triangle[t];
        double n[3];
        ss_normal3(n, mesh->position[c[0]], mesh->position[c[1]], mesh->position[c[2]]);
        for (int a = 0; a < 3; ++a) {
            for (int k = 0; k < 3; ++k) {
                model->normal[4 * (ptrdiff_t)c[a] + k] += (ss_real)(n[k] / 6.0);
            }
        }
        double r[3];
        ss_sub3(r, mesh->position[c[0]], mesh->position[0]);
        model->enclosed[body_of(model, c[0])].volume += ss_dot3(n, r) / 6.0;
    }
}

/* The largest (B/V_k) sum |N_i|^2/m_i; `square` has room for every body. */
static double largest_rate(const ss_model *model, double *square)
{
    if (model->enclosed_count == 1) {
        return model->material.bulk / model->enclosed[0].volume *
               model->kernels->weighted_square(&model->whole, model->normal, model->mobility);
    }
    double largest = 0.0;
    for (int32_t i = 0; i < model->node_count; ++i) {
        for (int a = 0; model->body[i] >= 0 && a < 3; ++a) {
            const double n = (double)model->normal[4 * (ptrdiff_t)i + a];
            square[model->body[i]] += n * n * (double)model->mobility[4 * (ptrdiff_t)i + a];
        }
    }
    for (int32_t k = 0; k < model->enclosed_count; ++k) {
        largest = fmax(largest, model->material.bulk / model->enclosed[k].volume * square[k]);
    }
    return largest;
}

softsim_status ss_cnn_enclosed_create(ss_model *model, softsim_error *error)
{
    if (!model->normal) {
        return SOFTSIM_OK;
    }
    const softsim_status status = find_bodies(model);
    if (status != SOFTSIM_OK) {
        return status;
    }
    set_volumes(model);
    for (int32_t k = 0; k < model->enclosed_count; ++k) {
        if (!(model->enclosed[k].volume > 0.0)) {
            softsim_error_add(error, SOFTSIM_ERROR_MESH,
                              "cnn-energy: enclosed_bulk_pa: the surface encloses no volume (is it "
                              "inside out?)");
            return SOFTSIM_ERROR_MESH;
        }
    }
    double *square = ss_memory_get((size_t)model->enclosed_count, sizeof *square);
    if (!square) {
        return SOFTSIM_ERROR_MEMORY;
    }
    model->bulk_rate = largest_rate(model, square);
    ss_memory_free(square);
    return SOFTSIM_OK;
}

/* ---- in a step ---- */

const ss_real *ss_cnn_enclosed_normal(const ss_model *model)
{
    return model->enclosed_count == 1 ? model->normal : NULL;
}

/* N_i.x_i of one node. */
static double node_change(const ss_model *model, int32_t i, const ss_real *x)
{
    double change = 0.0;
    for (ptrdiff_t at = 4 * (ptrdiff_t)i; at < 4 * (ptrdiff_t)i + 3; ++at) {
        change += (double)model->normal[at] * (double)x[at];
    }
    return change;
}

/* out_i += s N_i. */
static void add_normal(const ss_model *model, int32_t i, double s, ss_real *out)
{
    for (ptrdiff_t at = 4 * (ptrdiff_t)i; at < 4 * (ptrdiff_t)i + 3; ++at) {
        out[at] += (ss_real)s * model->normal[at];
    }
}

/* Of each of several bodies: `along`, its change of volume along x. */
static void sum_changes(const ss_model *model, const ss_real *x)
{
    ss_cnn_enclosed *enclosed = model->enclosed;
    for (int32_t k = 0; k < model->enclosed_count; ++k) {
        enclosed[k].along = 0.0;
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        if (model->body[i] >= 0) {
            enclosed[model->body[i]].along += node_change(model, i, x);
        }
    }
}

/* Of several bodies: changes of volume at `u`, pressures, and their forces. */
static void press_bodies(ss_model *model, const ss_real *u)
{
    ss_cnn_enclosed *enclosed = model->enclosed;
    sum_changes(model, u);
    for (int32_t k = 0; k < model->enclosed_count; ++k) {
        enclosed[k].change = enclosed[k].along;
        enclosed[k].pressure = model->material.bulk / enclosed[k].volume * enclosed[k].change;
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        if (model->body[i] >= 0) {
            add_normal(model, i, -enclosed[model->body[i]].pressure, model->force);
        }
    }
}

void ss_cnn_enclosed_evaluate(ss_model *model, const ss_real *u, double far_change)
{
    if (model->enclosed_count > 1) {
        press_bodies(model, u);
    } else if (model->enclosed_count == 1) {
        ss_cnn_enclosed *enclosed = model->enclosed;
        enclosed->pressure =
            model->material.bulk / enclosed->volume * (enclosed->change + far_change);
    }
}

/* The same of several. */
static double tangent_of_bodies(const ss_model *model, const ss_real *x, ss_real *out)
{
    ss_cnn_enclosed *enclosed = model->enclosed;
    double square = 0.0;
    sum_changes(model, x);
    for (int32_t k = 0; k < model->enclosed_count; ++k) {
        square += model->material.bulk / enclosed[k].volume * enclosed[k].along * enclosed[k].along;
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        if (model->body[i] >= 0) {
            const ss_cnn_enclosed *own = &enclosed[model->body[i]];
            add_normal(model, i, model->material.bulk / own->volume * own->along, out);
        }
    }
    return square;
}

double ss_cnn_enclosed_tangent(const ss_model *model, const ss_real *x, ss_real *out)
{
    if (model->enclosed_count != 1) {
        return model->enclosed_count > 1 ? tangent_of_bodies(model, x, out) : 0.0;
    }
    const double rate = model->material.bulk / model->enclosed[0].volume;
    const double change = model->kernels->dot(model->part, model->normal, x);
    model->kernels->axpy(model->part, rate * change, model->normal, out);
    return rate * change * change;
}

double ss_cnn_enclosed_energy(const ss_model *model)
{
    double energy = 0.0;
    for (int32_t k = 0; k < model->enclosed_count && model->material.bulk > 0.0; ++k) {
        const ss_cnn_enclosed *enclosed = &model->enclosed[k];
        energy +=
            0.5 * enclosed->pressure * enclosed->pressure * enclosed->volume / model->material.bulk;
    }
    return energy;
}
