/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/corotational/corotational.h"
/*
 * Implicit Euler. With the change of velocity e sought, w = v + e and u+ = u + h w,
 *
 *   r(e) = f_elastic(u+) - D w + f_loads + f_contact(u+) - M (e/h + alpha w) = 0
 *
 * on the axes that are free; fixed and prescribed ones have their places at the end already.
 * Newton:
 *
 *   (M (1/h + alpha) + D + h (K + K_contact)) de = r
 *
 * or, in dx = h de, (M (1/h^2 + alpha/h) + D/h + K + K_contact) dx = r, with K and D turned with
 * the elements (kernels.c) and the contact's and the grasps' stiffness: symmetric and
 * positive definite at any step, stiffness and shape. It begins from e = 0, where a smooth motion
 * nearly is. One iteration is usual; the residual at its end, which the next step needs in any
 * case, says whether it was enough, and a step that made it larger is halved. What a step leaves of
 * the residual is the next one's to remove.
 *
 * The first residual is taken from the last evaluation of the elements while all nodes are near
 * their places then, f(u) = f(u_last) - K (u - u_last): a product in place of the rotations.
 *
 * Linear solver: conjugate gradients with the diagonal. At the steps of a haptic loop the inertia
 * M/h^2 carries much of the matrix (stiffness reaches some 16 times it at 1 ms in 25,000
 * tetrahedra of 3 kPa), so that some eight products do, of 3.2 ns a tetrahedron each. Rejected: the
 * factor of the rest stiffness as preconditioner: for 4952 nodes it has 27 MB, which take 1.9 ms to
 * read forth and back, the time of 24 products with the matrix; blocks of 3x3 on the diagonal,
 * which save few products (those of inner nodes are nearly multiples of the identity) and would
 * have to be turned.
 *
 * It begins from the best multiple of the change of velocity in the step before, for one product:
 * in a smooth motion that is most of the solution (13.1 to 8.6 products a step, 19,069 tetrahedra
 * that swing under their weight).
 *
 * Enough: |r| <= tolerance of the larger of |r(0)| and a tenth of |f_loads + f_contact|, or what
 * the rounding of u alone amounts to; |r|^2 = r.P^-1 r, P the diagonal. Newton's iteration ends at
 * ten times the tolerance, since its error too is left to the next step. Where the budget ends it
 * before, the verdict says so.
 */
#include <math.h>
#include <string.h>

/* Of an edge: further from where the elements were evaluated their rotations may have changed. */
#define NEAR 0.02
/* Shares of the tolerance, see above. */
#define NEWTON_SHARE 10.0
#define LOAD_SHARE   0.1
/* Of u, of which forces cannot be known better; of an edge, where u is 0. */
#define ROUNDING      (sizeof(ss_real) == sizeof(float) ? 2e-7 : 4e-16)
#define SMALLEST_MOVE 1e-15
/* More of the residual than this times what was enough is no solution. */
#define MAX_LEFT 10.0
enum { MAX_HALVINGS = 2 };

/* ---- the law ---- */

static size_t bytes_of(const ss_model *model)
{
    return (size_t)model->scalar_count * sizeof(ss_real);
}

static void evaluate(ss_model *model, const ss_real *u)
{
    ss_corot_pass pass = {
        .blocks = &model->blocks, .u = u, .turned = model->turned, .force = model->elastic};
    memset(model->elastic, 0, bytes_of(model));
    model->kernels->evaluate(&pass);
    memcpy(model->evaluated_u, u, bytes_of(model));
    model->energy = pass.energy;
    model->inverted_count = pass.inverted_count;
    model->first_inverted = pass.first_inverted;
    model->is_evaluated = true;
    ++model->evaluation_count;
}

static void add(int32_t count, const ss_real *x, ss_real *out)
{
    for (int32_t k = 0; k < count; ++k) {
        out[k] += x[k];
    }
}

/* Adds the viscous force at velocities v, elements turned as last evaluated; returns its power. */
static double add_viscous(ss_model *model, const ss_real *v, ss_real *force)
{
    memset(model->product, 0, bytes_of(model));
    model->kernels->multiply(&model->blocks, model->turned, model->blocks.viscosity, -1.0, v,
                             model->product);
    add(model->scalar_count, model->product, force);
    return fmax(0.0, -model->kernels->dot(model->scalar_count, v, model->product));
}

void ss_corot_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                    ss_body_energy *out)
{
    ss_model *model = owner;
    if (!model->is_evaluated || memcmp(model->evaluated_u, u, bytes_of(model)) != 0) {
        evaluate(model, u);
    }
    add(model->scalar_count, model->elastic, force);
    out->elastic = model->energy;
    out->power = model->has_viscosity ? add_viscous(model, v, force) : 0.0;
}

void ss_corot_tangent(void *owner, const ss_real *x, ss_real *out)
{
    ss_model *model = owner;
    model->kernels->multiply(&model->blocks, model->turned, model->blocks.modulus, 1.0, x, out);
}

/* ---- one system ---- */

/* A sub-step on its way. */
typedef struct task {
    ss_model *model;
    ss_body *body;
    double h, path;
    double inertia; /* 1/h^2 + alpha/h */
    double size;    /* |r| by P^-1, and that of loads and contact */
    double load_size;
    double smallest; /* |r| that counts as zero */
} task;

static void set_system(ss_model *model, double h)
{
    if (model->system_step == h) {
        return;
    }
    model->system_step = h;
    const ss_fem_blocks *blocks = &model->blocks;
    const int32_t count = blocks->count * SS_FEM_MODULI * SS_FEM_LANES;
    for (int32_t k = 0; k < count; ++k) {
        model->system[k] = blocks->modulus[k];
        model->system[k] += model->has_viscosity ? (ss_real)((double)blocks->viscosity[k] / h) : 0;
    }
}

/* w = v + e, u = u0 + h w on free axes; prescribed ones stay. */
static void place(const task *t)
{
    ss_model *model = t->model;
    ss_body_nodes *nodes = ss_body_get_nodes(t->body);
    const ss_real h = (ss_real)t->h;
    for (int32_t k = 0; k < model->scalar_count; ++k) {
        const bool is_free = nodes->mobility[k] > 0;
        const ss_real w = model->old_v[k] + model->change[k];
        model->velocity[k] = w;
        nodes->u[k] = is_free ? model->old_u[k] + h * w : nodes->u[k];
    }
}

/* The elastic forces at u, by the tangent where that is near enough. */
static void add_elastic(task *t, const ss_real *u, bool may_guess, ss_real *force)
{
    ss_model *model = t->model;
    double furthest = 0.0;
    for (int32_t k = 0; may_guess && model->is_evaluated && k < model->scalar_count; ++k) {
        model->away[k] = u[k] - model->evaluated_u[k];
        furthest = fmax(furthest, fabs((double)model->away[k]));
    }
    const bool is_near = may_guess && model->is_evaluated && furthest <= NEAR * model->edge;
    if (!is_near) {
        evaluate(model, u);
    } else if (furthest > 0.0) {
        model->kernels->multiply(&model->blocks, model->turned, model->blocks.modulus, -1.0,
                                 model->away, force);
    }
    add(model->scalar_count, model->elastic, force);
}

static double square_of(const ss_real x[3])
{
    return (double)x[0] * (double)x[0] + (double)x[1] * (double)x[1] + (double)x[2] * (double)x[2];
}

/* P^-1 with the active contacts, 0 on axes that do not move; and the residual that counts as zero.
 */
static void set_inverse(task *t)
{
    ss_model *model = t->model;
    const ss_body_nodes *nodes = ss_body_read_nodes(t->body);
    const double least = SMALLEST_MOVE * SMALLEST_MOVE * model->edge * model->edge;
    const double rounding = ROUNDING * ROUNDING;
    double sum = 0.0;
    memset(model->contact, 0, (size_t)model->node_count * sizeof *model->contact);
    ss_body_contact_diagonal(t->body, model->contact);
    for (int32_t i = 0; i < model->node_count; ++i) {
        const ptrdiff_t at = 4 * (ptrdiff_t)i;
        const double stiff = model->stiff[i] + model->contact[i];
        const double diagonal = nodes->mass[i] * t->inertia + model->viscous[i] / t->h + stiff;
        const ss_real inverse = diagonal > 0.0 ? (ss_real)(1.0 / diagonal) : 0;
        for (ptrdiff_t k = at; k < at + 4; ++k) {
            model->inverse[k] = nodes->mobility[k] > 0 ? inverse : 0;
        }
        sum += (double)inverse * stiff * stiff * (rounding * square_of(nodes->u + at) + least);
    }
    t->smallest = sqrt(sum);
}

/* residual := r(e), and its size. */
static void set_residual(task *t, bool may_guess)
{
    ss_model *model = t->model;
    const ss_corot_kernels *kernels = model->kernels;
    ss_body_nodes *nodes = ss_body_get_nodes(t->body);
    place(t);
    ss_body_external(t->body, nodes->u, t->path);
    set_inverse(t);
    memcpy(model->residual, nodes->force, bytes_of(model));
    kernels->scale(model->scalar_count, 1.0, model->inverse, model->residual, model->scaled);
    t->load_size = sqrt(kernels->dot(model->scalar_count, model->residual, model->scaled));
    add_elastic(t, nodes->u, may_guess, model->residual);
    if (model->has_viscosity) {
        (void)add_viscous(model, model->velocity, model->residual);
    }
    const ss_real rate = (ss_real)(1.0 / t->h), alpha = (ss_real)model->material.mass_damping;
    for (int32_t k = 0; k < model->scalar_count; ++k) {
        model->residual[k] -=
            model->mass[k] * (rate * model->change[k] + alpha * model->velocity[k]);
    }
    kernels->scale(model->scalar_count, 1.0, model->inverse, model->residual, model->scaled);
    t->size = sqrt(kernels->dot(model->scalar_count, model->residual, model->scaled));
}

/* product := A search; returns search.product */
static double apply(task *t)
{
    ss_model *model = t->model;
    ++model->product_count;
    model->kernels->scale(model->scalar_count, t->inertia, model->mass, model->search,
                          model->product);
    model->kernels->multiply(&model->blocks, model->turned, model->system, 1.0, model->search,
                             model->product);
    ss_body_contact_tangent(t->body, model->search, model->product);
    return model->kernels->dot(model->scalar_count, model->search, model->product);
}

/* step += s search and what follows from it; returns |r|^2. */
static double descend(ss_model *model, double s)
{
    return model->kernels->descend(model->scalar_count, s, model->search, model->product,
                                   model->inverse, model->step, model->residual, model->scaled);
}

/* Conjugate gradients: step := dx, until |r| <= enough. They begin from the best multiple of the
 * last step's change where `has_start`. */
static void solve(task *t, double enough, bool has_start)
{
    ss_model *model = t->model;
    const ss_corot_kernels *kernels = model->kernels;
    const int32_t n = model->scalar_count;
    double rho = t->size * t->size;
    memset(model->step, 0, bytes_of(model));
    if (has_start) {
        memcpy(model->search, model->last, bytes_of(model));
        const double curvature = apply(t);
        if (curvature > 0.0) {
            rho = descend(model, kernels->dot(n, model->search, model->residual) / curvature);
        }
    }
    memcpy(model->search, model->scaled, bytes_of(model));
    while (rho > enough * enough && model->product_count < model->max_products) {
        const double curvature = apply(t);
        if (!(curvature > 0.0)) {
            break; /* nothing left but rounding */
        }
        const double next = descend(model, rho / curvature);
        kernels->turn(n, next / rho, model->scaled, model->search);
        rho = next;
    }
}

/* change += share dx / h */
static void take(const task *t, double share)
{
    ss_model *model = t->model;
    const ss_real rate = (ss_real)(share / t->h);
    for (int32_t k = 0; k < model->scalar_count; ++k) {
        model->change[k] += rate * model->step[k];
    }
}

/* ---- the sub-step ---- */

static double enough_of(const task *t, double first)
{
    return fmax(t->model->tolerance * fmax(first, LOAD_SHARE * t->load_size), t->smallest);
}

/* Newton's iteration; returns the residual over what is enough: above 1 the budget has ended it. */
static double iterate(task *t)
{
    ss_model *model = t->model;
    set_residual(t, true);
    const double first = t->size;
    double enough = enough_of(t, first);
    for (model->newton_count = 0; t->size > enough && model->newton_count < model->max_newton;
         ++model->newton_count) {
        const double before = t->size;
        solve(t, enough, model->newton_count == 0 && model->has_last);
        take(t, 1.0);
        set_residual(t, false);
        double share = 1.0;
        for (int k = 0; k < MAX_HALVINGS && t->size > before; ++k) {
            share *= 0.5;
            take(t, -share);
            set_residual(t, false);
        }
        enough = NEWTON_SHARE * enough_of(t, first);
    }
    return enough > 0.0 ? t->size / enough : 0.0;
}

void ss_corot_advance(void *owner, ss_body *body, double h, double path_end)
{
    ss_model *model = owner;
    ss_body_nodes *nodes = ss_body_get_nodes(body);
    task t = {.model = model,
              .body = body,
              .h = h,
              .path = path_end,
              .inertia = (1.0 / h + model->material.mass_damping) / h};
    set_system(model, h);
    memcpy(model->old_u, nodes->u, bytes_of(model));
    memcpy(model->old_v, nodes->v, bytes_of(model));
    memset(model->change, 0, bytes_of(model));
    model->product_count = model->evaluation_count = 0;
    model->left = iterate(&t);
    if (!(model->left <= MAX_LEFT)) {
        ss_body_judge(body, SOFTSIM_VERDICT_DEGRADED, 0,
                      "the step's equation was not solved within newton_iterations and "
                      "solver_iterations");
    } else if (model->left > 1.0) {
        ss_body_judge(body, SOFTSIM_VERDICT_GUARDED, 0,
                      "the step's equation was solved in part: the next one goes on with the rest");
    }
    for (int32_t k = 0; k < model->scalar_count; ++k) {
        const bool is_free = nodes->mobility[k] > 0;
        nodes->v[k] = is_free ? model->velocity[k] : nodes->v[k];
        model->last[k] = is_free ? (ss_real)h * model->change[k] : 0;
    }
    model->has_last = model->newton_count > 0;
    if (model->inverted_count > 0) {
        ss_body_judge(body, SOFTSIM_VERDICT_GUARDED, 0,
                      "an element was inside out and is being turned back");
    }
}
