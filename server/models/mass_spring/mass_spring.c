/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/body.h"
#include "models/common/plan.h"
/*
 * mass-spring: the edges of a mesh as springs and dampers between point masses.
 *
 * Force of an edge of rest length l0 between nodes i and j, n the unit vector from i to j:
 *
 *   f_i = (k (l - l0) + c n.(v_j - v_i)) n = -f_j
 *
 * with l - l0 = d.(2 r0 + d)/(l + l0), d = u_j - u_i and r0 the edge at rest: from displacements,
 * so that nothing cancels in single precision.
 *
 * Stiffness from Young's modulus: springs that all follow one affine strain eps store
 * sum k l0^2 (n.eps n)^2 / 2. Over directions that are equally frequent the mean of n n n n makes
 * of it, per volume, lambda = mu = sum k l0^2 / (15 V), hence E = 5/2 mu = sum k l0^2 / (6 V) and
 * nu = 1/4; per area lambda = mu = sum k l0^2 / (8 A), E t = sum k l0^2 / (3 A), nu = 1/3. Each
 * element gives its own edges k = 6 E V / (AFFINE sum l0^2) (triangles: 3 E t A / sum l0^2), the
 * sum over its own edges: meshes may be graded and E may vary. Nodes inside a volume do not follow
 * affinely and soften it to AFFINE of that: stretched blocks of Delaunay tetrahedra (500 to 1000
 * nodes) have 0.96 to 1.05 of E with it. That is no law: in a wall of one or two irregular
 * elements, with hardly a node inside, nodes leave the affine motion further, and the wall of a
 * ventricle (983 nodes, 949 of them on its surface) is 1.7 times as soft as asked; with 4473 nodes
 * it is 1.1 times. Poisson's ratio cannot be chosen, which is why there is no such parameter; and a
 * surface of springs does not resist bending. A damper has c = k 5/2 psi / E: the same formula with
 * a shear viscosity psi. Rejected: k = E sum V / l0^2 (van Gelder 1998), which lets flat elements
 * dominate; k as 1/l0 in an element, which halves that wall's error and triples that of a beam;
 * springs across elements, which make a volume stiffer in some directions than in others.
 *
 * Stable step, rigorous at any state: with S = k n n^T + k (1 - l0/l)+ (I - n n^T) the stiffness of
 * an edge (a squeezed one stiffens nothing) and A_i = sum S over the edges of node i, the node's
 * mass can be split over its edges as S / rho_i, rho_i >= lambda_max(A_i)/m_i: these add up to no
 * more than m_i. An edge with its split masses has omega^2 = rho_i + rho_j, and no mode of the
 * whole is above the largest of them (Rayleigh's quotient of sums). rho_i takes lambda_max <= mean
 * + sqrt (2/3) |deviator|, exact for one spring. A single spring, and a long chain, reach the
 * bound.
 *
 * Where the nonlinearity comes from: springs turn as the body deforms, and contact; each is linear
 * in its length. Left out: cutting and tearing. Springs never break.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/note.h"
#include "rt/order.h"
#include "rt/vec.h"

/* ---- parameters ---- */

enum {
    ROW_YOUNGS_MODULUS,
    ROW_DENSITY,
    ROW_THICKNESS,
    ROW_VISCOSITY,
    ROW_MASS_DAMPING,
    ROW_INTEGRATOR,
    ROW_COUNT
};

static const ss_param_row rows[ROW_COUNT] = {
    [ROW_YOUNGS_MODULUS] =
        SS_PARAM(FIELD, "youngs_modulus_pa",
                 "E of the tissue; springs have no other Poisson's ratio than 1/4 (surfaces 1/3)",
                 SS_ABOVE(0, 1e15), .is_required = true, .fallback = SS_ABSENT),
    [ROW_DENSITY] =
        SS_PARAM(FIELD, "density_kg_m3", "mass per volume", SS_ABOVE(0, 1e9), .fallback = 1000.0),
    [ROW_THICKNESS] = SS_PARAM(FIELD, "thickness_m", "of a surface mesh, where it is required",
                               SS_ABOVE(0, 1e6), .fallback = SS_ABSENT),
    [ROW_VISCOSITY] = SS_PARAM(FIELD, "viscosity_psi_pa_s",
                               "shear viscosity, as dampers along the springs", SS_FROM(0, 1e12)),
    [ROW_MASS_DAMPING] =
        SS_PARAM(NUMBER, "mass_damping_per_s",
                 "damping per mass: it damps all modes, and free flight", SS_FROM(0, 1e9)),
    [ROW_INTEGRATOR] =
        SS_PARAM(CHOICE, "integrator", "rk4 costs four times as much and loses energy",
                 .range.max = 1.0, .choices = "symplectic-euler|rk4"),
};

/* E of a network of tetrahedra's edges over that of the same springs moving affinely. */
#define AFFINE 0.93
/* Of the stable step, which is looked at in every fourth step: the margin is far wider than what
 * the body changes in between. */
#define STEP_SHARE 0.5
enum { LOOK_EVERY = 4 };
/* Microseconds a sub-step, an edge and a tool. */
#define COST_STEP 2.0
#define COST_EDGE 0.008
#define COST_TOOL 15.0

typedef struct edge {
    int32_t from, to;                   /* node number x 4 */
    ss_real arm[3];                     /* m, at rest, from `from` to `to` */
    ss_real length, stiffness, damping; /* m, N/m, N s/m */
} edge;

struct ss_model {
    ss_body *body; /* first, as ss_body_model_... take it */
    ss_arena arena;
    int32_t edge_count;
    edge *edge;
    bool has_dampers;
    bool is_volume;
    double viscous_time; /* s, the largest c / k */
    ss_body_integrator integrator;
    double damping;
    double *block;    /* A_i: xx yy zz xy yz zx, a node */
    int32_t age;      /* calls of stable_step since the last look */
    double seen_step; /* s, then */
    double stiffness_min, stiffness_max;
};

/* ---- forces ---- */

/* An edge as it lies now. */
typedef struct stretched {
    ss_real n[3], length, extension;
} stretched;

static inline void stretch(const edge *e, const ss_real *u, stretched *out)
{
    ss_real square = 0, along = 0;
    for (int k = 0; k < 3; ++k) {
        const ss_real d = u[e->to + k] - u[e->from + k];
        out->n[k] = e->arm[k] + d;
        square += out->n[k] * out->n[k];
        along += d * (2 * e->arm[k] + d);
    }
#ifdef SOFTSIM_DOUBLE
    out->length = sqrt(square);
#else
    out->length = sqrtf(square);
#endif
    out->extension = along / (out->length + e->length);
    const ss_real inverse = out->length > 0 ? 1 / out->length : 0; /* no direction: no force */
    for (int k = 0; k < 3; ++k) {
        out->n[k] *= inverse;
    }
}

static void force(void *owner, const ss_real *u, const ss_real *v, ss_real *f, ss_body_energy *out)
{
    const ss_model *model = owner;
    double elastic = 0.0, power = 0.0;
    for (int32_t k = 0; k < model->edge_count; ++k) {
        const edge *e = &model->edge[k];
        stretched now;
        stretch(e, u, &now);
        ss_real pull = e->stiffness * now.extension;
        if (out->is_wanted) {
            elastic += (double)(pull * now.extension);
        }
        if (model->has_dampers) {
            const ss_real rate = now.n[0] * (v[e->to] - v[e->from]) +
                                 now.n[1] * (v[e->to + 1] - v[e->from + 1]) +
                                 now.n[2] * (v[e->to + 2] - v[e->from + 2]);
            pull += e->damping * rate;
            power += (double)(e->damping * rate * rate);
        }
        for (int a = 0; a < 3; ++a) {
            f[e->from + a] += pull * now.n[a];
            f[e->to + a] -= pull * now.n[a];
        }
    }
    out->elastic = 0.5 * elastic;
    out->power = power;
}

/* Tension of a stretched edge over its length: stiffness across it; none of a squeezed one. */
static inline ss_real across(const edge *e, const stretched *now)
{
    return now->extension > 0 ? e->stiffness * now->extension / now->length : 0;
}

static void tangent(void *owner, const ss_real *x, ss_real *out)
{
    const ss_model *model = owner;
    const ss_real *u = ss_body_read_nodes(model->body)->u;
    for (int32_t k = 0; k < model->edge_count; ++k) {
        const edge *e = &model->edge[k];
        stretched now;
        ss_real d[3], along = 0;
        stretch(e, u, &now);
        for (int a = 0; a < 3; ++a) {
            d[a] = x[e->from + a] - x[e->to + a];
            along += now.n[a] * d[a];
        }
        const ss_real side = across(e, &now);
        const ss_real main = (e->stiffness - side) * along;
        for (int a = 0; a < 3; ++a) {
            const ss_real change = main * now.n[a] + side * d[a];
            out[e->from + a] += change;
            out[e->to + a] -= change;
        }
    }
}

static void diagonal(void *owner, double *out)
{
    const ss_model *model = owner;
    for (int32_t k = 0; k < model->edge_count; ++k) {
        const edge *e = &model->edge[k];
        out[e->from / 4] += (double)e->stiffness / 3.0;
        out[e->to / 4] += (double)e->stiffness / 3.0;
    }
}

/* ---- the stable step ---- */

/* From above: mean + sqrt(2/3) |deviator|. */
static double largest_eigenvalue(const double a[6])
{
    const double mean = (a[0] + a[1] + a[2]) / 3.0;
    double square = 2.0 * (a[3] * a[3] + a[4] * a[4] + a[5] * a[5]);
    for (int k = 0; k < 3; ++k) {
        square += (a[k] - mean) * (a[k] - mean);
    }
    return mean + sqrt(2.0 / 3.0 * square);
}

static void add_block(double a[6], const stretched *now, double main, double side)
{
    const double x = (double)now->n[0], y = (double)now->n[1], z = (double)now->n[2];
    const double more = main - side;
    a[0] += more * x * x + side;
    a[1] += more * y * y + side;
    a[2] += more * z * z + side;
    a[3] += more * x * y;
    a[4] += more * y * z;
    a[5] += more * z * x;
}

static double stable_step(void *owner, const ss_body *body)
{
    ss_model *model = owner;
    const ss_body_nodes *nodes = ss_body_read_nodes(body);
    double rate2 = 0.0;
    if (model->age++ % LOOK_EVERY != 0) {
        return model->seen_step;
    }
    memset(model->block, 0, (size_t)nodes->count * 6 * sizeof *model->block);
    for (int32_t k = 0; k < model->edge_count; ++k) {
        const edge *e = &model->edge[k];
        stretched now;
        stretch(e, nodes->u, &now);
        const double side = (double)across(e, &now);
        add_block(model->block + 6 * (ptrdiff_t)(e->from / 4), &now, (double)e->stiffness, side);
        add_block(model->block + 6 * (ptrdiff_t)(e->to / 4), &now, (double)e->stiffness, side);
    }
    /* The first of the six becomes rho. */
    for (int32_t i = 0; i < nodes->count; ++i) {
        const ss_real *m = nodes->mobility + 4 * (ptrdiff_t)i;
        const double light = (double)fmax(fmax((double)m[0], (double)m[1]), (double)m[2]);
        double *a = model->block + 6 * (ptrdiff_t)i;
        a[0] = light > 0.0 ? light * largest_eigenvalue(a) : 0.0;
    }
    for (int32_t k = 0; k < model->edge_count; ++k) {
        const edge *e = &model->edge[k];
        const double from = model->block[6 * (ptrdiff_t)(e->from / 4)];
        const double to = model->block[6 * (ptrdiff_t)(e->to / 4)];
        rate2 = fmax(rate2, from + to);
    }
    model->seen_step =
        ss_body_step_limit(model->integrator, rate2, model->viscous_time, model->damping);
    return model->seen_step;
}

static void reset_state(void *owner)
{
    ss_model *model = owner;
    model->age = 0;
}

static uint64_t hash_state(const void *owner, uint64_t seed)
{
    const ss_model *model = owner;
    const uint64_t hash = ss_hash_bytes(seed, &model->age, sizeof model->age);
    return ss_hash_bytes(hash, &model->seen_step, sizeof model->seen_step);
}

/* ---- set-up ---- */

static double element_value(const ss_model_plan *plan, int row, const int32_t *corner, int count)
{
    double sum = 0.0;
    for (int a = 0; a < count; ++a) {
        sum += ss_plan_node_value(&plan->param[row], corner[a]);
    }
    return sum / count;
}

typedef struct draft_edge {
    int32_t low, high;
    double stiffness, damping;
} draft_edge;

static int compare_edges(const void *left, const void *right)
{
    const draft_edge *a = left, *b = right;
    return ss_order_then(ss_order_int(a->low, b->low), ss_order_int(a->high, b->high));
}

static double edge_length(const ss_mesh *mesh, int32_t a, int32_t b)
{
    double d[3];
    ss_sub3(d, mesh->position[b], mesh->position[a]);
    return ss_norm3(d);
}

/* Edges of one element, each with its k, into `out`; returns their number. */
static int32_t draft_element(const ss_model_plan *plan, const int32_t *c, int corners,
                             draft_edge *out)
{
    const ss_mesh *mesh = plan->mesh;
    double squares = 0.0, a[3], b[3], d[3], n[3];
    int32_t count = 0;
    for (int i = 0; i < corners; ++i) {
        for (int j = i + 1; j < corners; ++j) {
            const double l = edge_length(mesh, c[i], c[j]);
            squares += l * l;
            out[count++] =
                (draft_edge){.low = c[i] < c[j] ? c[i] : c[j], .high = c[i] < c[j] ? c[j] : c[i]};
        }
    }
    ss_sub3(a, mesh->position[c[1]], mesh->position[c[0]]);
    ss_sub3(b, mesh->position[c[2]], mesh->position[c[0]]);
    ss_cross3(n, a, b);
    double size = 0.0; /* k = E size: 6 V over, or 3 t A */
    if (corners == 4) {
        ss_sub3(d, mesh->position[c[3]], mesh->position[c[0]]);
        size = fabs(ss_dot3(n, d)) / (AFFINE * squares);
    } else {
        size = 1.5 * ss_norm3(n) * element_value(plan, ROW_THICKNESS, c, 3) / squares;
    }
    const double modulus = element_value(plan, ROW_YOUNGS_MODULUS, c, corners);
    const double viscosity = 2.5 * element_value(plan, ROW_VISCOSITY, c, corners);
    for (int32_t k = 0; k < count; ++k) {
        out[k].stiffness = modulus * size;
        out[k].damping = viscosity * size;
    }
    return count;
}

/* Joins the drafts of equal ends; returns how many are left. */
static int32_t join_edges(draft_edge *draft, int32_t count)
{
    int32_t kept = 0;
    qsort(draft, (size_t)count, sizeof *draft, compare_edges);
    for (int32_t k = 0; k < count; ++k) {
        if (kept > 0 && compare_edges(&draft[kept - 1], &draft[k]) == 0) {
            draft[kept - 1].stiffness += draft[k].stiffness;
            draft[kept - 1].damping += draft[k].damping;
        } else {
            draft[kept++] = draft[k];
        }
    }
    return kept;
}

static void set_edge(ss_model *model, const ss_mesh *mesh, const draft_edge *from, edge *out)
{
    double arm[3];
    ss_sub3(arm, mesh->position[from->high], mesh->position[from->low]);
    out->from = 4 * from->low;
    out->to = 4 * from->high;
    out->length = (ss_real)ss_norm3(arm);
    out->stiffness = (ss_real)from->stiffness;
    out->damping = (ss_real)from->damping;
    for (int k = 0; k < 3; ++k) {
        out->arm[k] = (ss_real)arm[k];
    }
    if (from->damping > 0.0) {
        model->has_dampers = true;
        model->viscous_time = fmax(model->viscous_time, from->damping / from->stiffness);
    }
    model->stiffness_min = fmin(model->stiffness_min, from->stiffness);
    model->stiffness_max = fmax(model->stiffness_max, from->stiffness);
}

static softsim_status create_edges(ss_model *model, const ss_model_plan *plan)
{
    const ss_mesh *mesh = plan->mesh;
    const size_t limit =
        model->is_volume ? 6 * (size_t)mesh->tetrahedron_count : 3 * (size_t)mesh->triangle_count;
    draft_edge *draft = ss_memory_get(limit, sizeof *draft);
    if (!draft || limit > INT32_MAX) {
        ss_memory_free(draft);
        return SOFTSIM_ERROR_MEMORY;
    }
    int32_t count = 0;
    for (int32_t t = 0; model->is_volume && t < mesh->tetrahedron_count; ++t) {
        count += draft_element(plan, mesh->tetrahedron[t], 4, draft + count);
    }
    for (int32_t t = 0; !model->is_volume && t < mesh->triangle_count; ++t) {
        count += draft_element(plan, mesh->triangle[t], 3, draft + count);
    }
    count = join_edges(draft, count);
    model->edge = ss_arena_get(&model->arena, (size_t)count, sizeof *model->edge);
    model->stiffness_min = (double)INFINITY;
    for (int32_t k = 0; model->edge && k < count; ++k) {
        set_edge(model, mesh, &draft[k], &model->edge[k]);
    }
    model->edge_count = count;
    ss_memory_free(draft);
    return ss_arena_status(&model->arena);
}

static softsim_status check_rows(const ss_model_plan *plan, bool is_volume, softsim_error *error)
{
    const ss_param_value *thickness = &plan->param[ROW_THICKNESS];
    if (!is_volume && !thickness->is_given) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "mass-spring: a surface mesh needs thickness_m, or give a mesh of "
                          "tetrahedra");
        return SOFTSIM_ERROR_SCENE;
    }
    if (is_volume && thickness->is_given) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "mass-spring: thickness_m is for surface meshes: take it out");
        return SOFTSIM_ERROR_SCENE;
    }
    return SOFTSIM_OK;
}

/* Masses, and the body that holds them. */
static softsim_status create_body(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    const ss_mesh *mesh = plan->mesh;
    const size_t n = (size_t)mesh->node_count;
    ss_arena scratch = {0};
    double *density = ss_arena_get(&scratch, n, sizeof *density);
    double *mass = ss_arena_get(&scratch, n, sizeof *mass);
    softsim_status status = ss_arena_status(&scratch);
    for (int32_t i = 0; status == SOFTSIM_OK && i < mesh->node_count; ++i) {
        density[i] = ss_plan_node_value(&plan->param[ROW_DENSITY], i) *
                     (model->is_volume ? 1.0 : ss_plan_node_value(&plan->param[ROW_THICKNESS], i));
    }
    if (status == SOFTSIM_OK && model->is_volume) {
        ss_body_volume_masses(mesh, density, false, mass);
    } else if (status == SOFTSIM_OK) {
        ss_body_area_masses(mesh, density, mass);
    }
    const ss_body_plan body = {
        .name = "mass-spring",
        .plan = plan,
        .node_count = mesh->node_count,
        .mass = mass,
        .mass_damping = model->damping,
        .edge = ss_body_mean_edge(mesh),
        .step_share = STEP_SHARE,
        .integrator = model->integrator,
        .elastic = {SS_BODY_ELASTIC(model, force, tangent, diagonal, stable_step),
                    .reset = reset_state, .hash = hash_state, .viscous_time = model->viscous_time}};
    if (status == SOFTSIM_OK) {
        status = ss_body_create(&body, &model->body, error);
    }
    ss_arena_free(&scratch);
    return status;
}

static void destroy(ss_model *model)
{
    ss_body_destroy(&model->body);
    ss_arena_free(&model->arena);
    ss_memory_free(model);
}

static softsim_status build(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    model->is_volume = plan->mesh->tetrahedron_count > 0;
    model->damping = plan->param[ROW_MASS_DAMPING].number;
    model->integrator =
        plan->param[ROW_INTEGRATOR].number != 0.0 ? SS_BODY_RK4 : SS_BODY_SYMPLECTIC_EULER;
    const softsim_status checked = check_rows(plan, model->is_volume, error);
    const size_t blocks = (size_t)plan->mesh->node_count * 6;
    model->block = ss_arena_get(&model->arena, blocks, sizeof *model->block);
    softsim_status status = checked == SOFTSIM_OK ? create_edges(model, plan) : checked;
    status = status == SOFTSIM_OK ? create_body(model, plan, error) : status;
    return status == SOFTSIM_OK ? ss_body_start(model->body) : status;
}

/* ---- the class ---- */

static double step_cost_us(const ss_model_plan *plan)
{
    const ss_mesh *mesh = plan->mesh;
    const int32_t tools = ss_plan_tool_count(plan);
    /* Edges by Euler's formula: n + tets + half the surface's triangles, or 3/2 triangles. */
    const double edges = mesh->tetrahedron_count > 0 ? mesh->node_count + mesh->tetrahedron_count +
                                                           0.5 * mesh->triangle_count
                                                     : 1.5 * mesh->triangle_count;
    return COST_STEP + COST_EDGE * edges * (1.0 + tools) + COST_TOOL * tools;
}

static void step(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    ss_body_step(model->body, time, dt, tool);
    ss_body_judge_inverted(model->body, true); /* a model of nodes */
}

static void explain(const ss_model *model, const ss_notes *out)
{
    ss_note_used(
        out, "springs", "%d edges of %s, %.4g to %.4g N/m, %s", model->edge_count,
        model->is_volume ? "tetrahedra" : "triangles", model->stiffness_min, model->stiffness_max,
        model->is_volume ? "Poisson's ratio 1/4" : "Poisson's ratio 1/3, no bending stiffness");
    if (model->has_dampers) {
        ss_note_used(out, "dampers", "along every spring");
    } else {
        ss_note_left_out(out, "dampers", "model.viscosity_psi_pa_s=1e-30",
                         "viscosity_psi_pa_s is 0");
    }
    ss_body_explain(model->body, out);
}

static const ss_model_hints hints = {
    .colour = "#8c6d1f",
    .about =
        "springs along edges: one elastic constant, Poisson's ratio near 1/4 whatever is asked "
        "for, and a stiffness that depends on how the mesh was cut: a wall of one or two "
        "irregular elements can be half as stiff as asked",
    .has_force = true,
    .fitted = {{"youngs_modulus_pa", false, 0.0},
               {"lame_mu_pa", false, 0.0},
               {"mass_damping_per_s", true, 0.0}}};

SS_MODEL_CLASS(ss_model_mass_spring, "mass-spring",
               "the edges of a volume or surface mesh as springs between point masses",
               SS_MODEL_PARTS(ss_model, &hints, rows, step_cost_us, build, destroy, step, explain),
               SS_BODY_STATE(ss_body_model_info, SS_BODY_MOTION));
