/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/hybrid/hybrid.h"
/*
 * One volume, shared by tetrahedra and particles.
 *
 * Every particle p stands for a volume V_p, of which the fraction a_p, its blend, is integrated by
 * itself. At most that is all of it in the layer, and the collar's share c_p of a ghost, which
 * falls from 1 beside the layer to 0 a face's diagonal further in. What particles do not integrate
 * now, cells do, coarse points each with the mean gradient of some tetrahedra (cells.c):
 *
 *   E = sum_e V_e W(F_e) + sum_c V_c W(F_c) + sum_p a_p V_p [W(F_p) + residual + cohesion]
 *   V_e = |e| - sum over its ghosts c_p V_p      V_c = sum over its guests (c_p - a_p) V_p
 *
 * The weights of every piece of material add up to 1, whatever sleeps: that is the partition of
 * unity that the paper's eq. (11), a sum of both interpolations, lacks (it doubles the overlap).
 * Two old problems are one then. The collar, without which the particles hang on the core by a
 * seventh of what they should, is the ghosts' share; and a thin wall does not soften where its skin
 * sleeps, because its energy goes on being counted. A sleeping particle's mass is on the four nodes
 * of the tetrahedron that reaches out to it best.
 *
 * Neighbours of an awake particle blend in to a falling degree, from 1 beside it to 0 at the
 * distance of a face's diagonal: what lies next to the awake region is integrated on both sides, as
 * inside a whole layer. Out to a cell's diagonal there are a quarter more points to integrate, and
 * forces are no nearer to those of a whole layer. Blends move in small steps: forces have no jumps.
 *
 * The law is the tetrahedra's own: a point is an element on three unit edges whose corners move by
 * the columns of H = F - I (layer_kernels.h).
 */
#include <math.h>
#include <string.h>

#include "models/common/dispatch.h"
#include "models/common/wide.h"

/* ---- lanes ---- */

typedef struct lane_values {
    double lambda, mu, kappa, phi, psi, volume; /* all times the volume but itself */
} lane_values;

static void put_lane(ss_fem_blocks *blocks, int32_t lane, const lane_values *value)
{
    const ptrdiff_t b = lane / SS_FEM_LANES;
    const int l = lane % SS_FEM_LANES;
    ss_real *modulus = blocks->modulus + b * SS_FEM_MODULI * SS_FEM_LANES + l;
    modulus[0] = (ss_real)value->lambda;
    modulus[SS_FEM_LANES] = (ss_real)value->mu;
    blocks->kappa[b * SS_FEM_LANES + l] = (ss_real)value->kappa;
    blocks->volume[b * SS_FEM_LANES + l] = (ss_real)value->volume;
    if (blocks->viscosity != NULL) {
        ss_real *viscosity = blocks->viscosity + b * 2 * SS_FEM_LANES + l;
        viscosity[0] = (ss_real)value->phi;
        viscosity[SS_FEM_LANES] = (ss_real)value->psi;
    }
}

/* Material of element e over `volume`, of which the share `cohesion` is the pair potential's. */
static lane_values values_of(const ss_fem_material *material, int32_t e, double volume,
                             double cohesion)
{
    const double mu = volume * material->mu[e];
    const double lambda = volume * material->lambda[e];
    return (lane_values){.lambda = lambda - cohesion * mu,
                         .mu = (1.0 - cohesion) * mu,
                         .kappa = lambda + 2.0 * mu,
                         .phi = material->phi != NULL ? volume * material->phi[e] : 0.0,
                         .psi = material->psi != NULL ? volume * material->psi[e] : 0.0,
                         .volume = volume};
}

void ss_hybrid_write_element(ss_hybrid *hybrid, int32_t e)
{
    const lane_values value = values_of(&hybrid->material, e, hybrid->volume[e], 0.0);
    put_lane(&hybrid->core, hybrid->lane[e], &value);
}

void ss_hybrid_write_cell(ss_hybrid *hybrid, int32_t c)
{
    const double volume = hybrid->cell_volume[c];
    const lane_values value = {.lambda = volume * hybrid->cell_lambda[c],
                               .mu = volume * hybrid->cell_mu[c],
                               .kappa =
                                   volume * (hybrid->cell_lambda[c] + 2.0 * hybrid->cell_mu[c]),
                               .phi = volume * hybrid->cell_phi[c],
                               .psi = volume * hybrid->cell_psi[c],
                               .volume = volume};
    put_lane(&hybrid->cell_blocks, c, &value);
}

static void write_point(ss_hybrid *hybrid, int32_t k)
{
    const ss_layer *layer = hybrid->layer;
    const int32_t p = hybrid->point[k];
    const double volume = (double)hybrid->particle[p].blend * layer->volume[p];
    const double mu = volume * hybrid->material.mu[layer->host[p]];
    const int32_t pairs = layer->pair_first[p + 1] - layer->pair_first[p];
    const lane_values value =
        values_of(&hybrid->material, layer->host[p], volume, hybrid->cohesion);
    put_lane(&hybrid->points, k, &value);
    hybrid->coefficient[2 * k] =
        (ss_real)(hybrid->stabilisation * mu) * layer->moment[8 * (ptrdiff_t)p + 6];
    hybrid->coefficient[2 * k + 1] = (ss_real)(10.0 * hybrid->cohesion * mu / pairs);
}

/* Roots of the weights at distances of a spacing and of root 2 spacings; least blend worth a point.
 */
#define ROOT_AT_EDGE 0.6326
#define ROOT_AT_FACE 0.3264
#define BLEND_FLOOR  0.02

double ss_hybrid_blend_beside(double weight)
{
    const double blend = (sqrt(weight) - ROOT_AT_FACE) / (ROOT_AT_EDGE - ROOT_AT_FACE);
    return blend > BLEND_FLOOR ? fmin(blend, 1.0) : 0.0;
}

double ss_hybrid_full_blend(const ss_hybrid *hybrid, int32_t p)
{
    const ss_layer *layer = hybrid->layer;
    if (p < layer->own_count) {
        return 1.0;
    }
    for (int32_t t = layer->pair_first[p]; t < layer->pair_first[p + 1]; ++t) {
        if (layer->neighbour[t] < layer->own_count) { /* nearest first */
            const bool has_gradient = layer->moment[8 * (ptrdiff_t)p + 6] > 0;
            return has_gradient ? ss_hybrid_blend_beside((double)layer->pair[4 * (ptrdiff_t)t + 3])
                                : 0.0;
        }
    }
    return 0.0;
}

void ss_hybrid_set_blend(ss_hybrid *hybrid, int32_t p, double blend)
{
    ss_hybrid_particle *particle = &hybrid->particle[p];
    const double taken = (blend - (double)particle->blend) * hybrid->layer->volume[p];
    hybrid->cell_volume[hybrid->cell_of[p]] -= taken;
    ss_hybrid_write_cell(hybrid, hybrid->cell_of[p]);
    particle->blend = (ss_real)blend;
    write_point(hybrid, particle->point);
}

/* ---- points ---- */

static void need(ss_hybrid *hybrid, int32_t p)
{
    ss_hybrid_particle *particle = &hybrid->particle[p];
    if (particle->need++ == 0) {
        particle->near = hybrid->near_count;
        hybrid->near[hybrid->near_count++] = p;
    }
}

static void release(ss_hybrid *hybrid, int32_t p)
{
    ss_hybrid_particle *particle = &hybrid->particle[p];
    if (--particle->need == 0) {
        const int32_t last = hybrid->near[--hybrid->near_count];
        hybrid->near[particle->near] = last;
        hybrid->particle[last].near = particle->near;
        particle->near = -1;
    }
}

void ss_hybrid_add_point(ss_hybrid *hybrid, int32_t p)
{
    const ss_layer *layer = hybrid->layer;
    const int32_t k = hybrid->point_count++;
    hybrid->is_near_old = true;
    hybrid->point[k] = p;
    hybrid->particle[p].point = k;
    hybrid->particle[p].blend = 0;
    hybrid->points.count = (hybrid->point_count + SS_FEM_LANES - 1) / SS_FEM_LANES;
    write_point(hybrid, k);
    need(hybrid, p);
    for (int32_t t = layer->pair_first[p]; t < layer->pair_first[p + 1]; ++t) {
        need(hybrid, layer->neighbour[t]);
    }
}

void ss_hybrid_remove_point(ss_hybrid *hybrid, int32_t p)
{
    static const lane_values nothing = {0};
    const ss_layer *layer = hybrid->layer;
    const int32_t k = hybrid->particle[p].point;
    const int32_t last = --hybrid->point_count;
    hybrid->is_near_old = true;
    ss_hybrid_set_blend(hybrid, p, 0.0);
    hybrid->particle[p].point = -1;
    if (k != last) {
        hybrid->point[k] = hybrid->point[last];
        hybrid->particle[hybrid->point[k]].point = k;
        write_point(hybrid, k);
    }
    put_lane(&hybrid->points, last, &nothing);
    /* A spare lane is looked at all the same: for the largest strain, and 0 times what is no number
     * is no energy. */
    memset(hybrid->gradient + 8 * (ptrdiff_t)(1 + 3 * last), 0, 24 * sizeof *hybrid->gradient);
    hybrid->points.count = (hybrid->point_count + SS_FEM_LANES - 1) / SS_FEM_LANES;
    release(hybrid, p);
    for (int32_t t = layer->pair_first[p]; t < layer->pair_first[p + 1]; ++t) {
        release(hybrid, layer->neighbour[t]);
    }
}

/* ---- forces ---- */

static ss_layer_pass pass_of(ss_hybrid *hybrid, const ss_real *u, const ss_real *v, ss_real *force)
{
    ss_hybrid_gather_near(hybrid);
    return (ss_layer_pass){&hybrid->near_rows,
                           u,
                           v,
                           force,
                           hybrid->state,
                           hybrid->particle_force,
                           hybrid->coefficient,
                           hybrid->gradient,
                           hybrid->spread,
                           hybrid->stress};
}

static ss_fem_pass core_pass(const ss_hybrid *hybrid, const ss_real *u)
{
    return (ss_fem_pass){.blocks = &hybrid->core, .kind = hybrid->material.kind, .u = u};
}

/* The points' columns: pairs, of which u is the first quad and v the second. */
static ss_fem_pass point_pass(const ss_hybrid *hybrid)
{
    return (ss_fem_pass){
        .blocks = &hybrid->points, .kind = hybrid->material.kind, .u = hybrid->gradient};
}

static ss_fem_pass cell_pass(const ss_hybrid *hybrid)
{
    return (ss_fem_pass){.blocks = &hybrid->cell_blocks,
                         .kind = hybrid->material.kind,
                         .u = hybrid->cells.gradient,
                         .out = hybrid->cells.stress};
}

static void clear_stress(ss_real *stress, int32_t count)
{
    memset(stress, 0, 8 * (size_t)(1 + 3 * count) * sizeof *stress);
}

/* Energy of the points' residuals at the state of the last strain, J. */
static double residual_energy(const ss_hybrid *hybrid)
{
    double energy = 0.0;
    for (ptrdiff_t k = 0; k < hybrid->point_count; ++k) {
        const ss_real *spread = hybrid->spread + 8 * k;
        energy += 0.5 * (double)hybrid->coefficient[2 * k] *
                  ((double)spread[0] + (double)spread[1] + (double)spread[2]);
    }
    return energy;
}

static void add_cells(ss_hybrid *hybrid, const ss_real *u, const ss_real *v, ss_real *force,
                      ss_body_energy *out)
{
    ss_fem_pass pass = cell_pass(hybrid);
    hybrid->kernels->strain_cells(&hybrid->cells, u, v);
    clear_stress(hybrid->cells.stress, hybrid->cells.count);
    pass.v = v != NULL ? hybrid->cells.gradient + 4 : NULL;
    pass.wants_energy = out->is_wanted;
    hybrid->law->force(&pass);
    hybrid->kernels->push_cells(&hybrid->cells, force);
    out->elastic += pass.energy;
    out->power += pass.power;
}

void ss_hybrid_force(void *owner, const ss_real *u, const ss_real *v, ss_real *force,
                     ss_body_energy *out)
{
    ss_hybrid *hybrid = owner;
    const bool is_viscous = hybrid->core.viscosity != NULL;
    ss_fem_pass core = core_pass(hybrid, u);
    core.v = is_viscous ? v : NULL;
    core.out = force;
    core.wants_energy = out->is_wanted;
    hybrid->law->force(&core);
    out->elastic += core.energy;
    out->power += core.power;
    hybrid->u = u;
    hybrid->strain = fmax(hybrid->strain, sqrt(core.strain));
    add_cells(hybrid, u, is_viscous ? v : NULL, force, out);
    if (hybrid->point_count == 0) {
        return;
    }
    const ss_layer_pass pass = pass_of(hybrid, u, is_viscous ? v : NULL, force);
    ss_fem_pass points = point_pass(hybrid);
    hybrid->kernels->place(&pass);
    hybrid->kernels->strain(&pass);
    clear_stress(hybrid->stress, hybrid->point_count);
    points.v = is_viscous ? hybrid->gradient + 4 : NULL;
    points.out = hybrid->stress;
    points.wants_energy = out->is_wanted;
    hybrid->law->force(&points);
    out->elastic += hybrid->kernels->push(&pass, hybrid->cohesion > 0.0, out->is_wanted);
    hybrid->kernels->give(&pass);
    out->elastic += points.energy + (out->is_wanted ? residual_energy(hybrid) : 0.0);
    out->power += points.power;
    hybrid->strain = fmax(hybrid->strain, sqrt(points.strain));
}

/* Cohesion's stiffness at rest, 3 e/r0^2 along each pair, of which a point has half. */
static void add_cohesion_tangent(ss_hybrid *hybrid)
{
    const ss_layer_near *near = &hybrid->near_rows;
    for (ptrdiff_t k = 0; k < near->point_count; ++k) {
        for (ptrdiff_t t = near->pair_first[k]; t < near->pair_first[k + 1]; ++t) {
            const ptrdiff_t q = near->neighbour[t];
            const ss_real *row = near->pair + 4 * t; /* w X: only its direction counts */
            const ss_real square = row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
            ss_real along = 0;
            for (int a = 0; a < 3; ++a) {
                along += row[a] * (hybrid->state[8 * q + a] - hybrid->state[8 * k + a]);
            }
            const ss_real stiffness = (ss_real)1.5 * hybrid->coefficient[2 * k + 1] * row[3] *
                                      row[3] / square; /* e/r0^2 */
            for (int a = 0; a < 3; ++a) {
                const ss_real f = stiffness * along / square * row[a];
                hybrid->particle_force[4 * k + a] += f;
                hybrid->particle_force[4 * q + a] -= f;
            }
        }
    }
}

void ss_hybrid_tangent(void *owner, const ss_real *x, ss_real *out)
{
    ss_hybrid *hybrid = owner;
    ss_fem_pass core = core_pass(hybrid, hybrid->u);
    core.x = x;
    core.out = out;
    hybrid->law->tangent(&core);
    ss_fem_pass cells = cell_pass(hybrid);
    cells.x = hybrid->cells.gradient + 4;
    hybrid->kernels->strain_cells(&hybrid->cells, hybrid->u, x);
    clear_stress(hybrid->cells.stress, hybrid->cells.count);
    hybrid->law->tangent(&cells);
    hybrid->kernels->push_cells(&hybrid->cells, out);
    if (hybrid->point_count == 0) {
        return;
    }
    /* The gradients of the state stay in the first quads, those of x go to the second. `push` makes
     * forces, -K x, of what the law's tangent gives with the other sign. */
    ss_layer_pass pass = pass_of(hybrid, hybrid->u, x, out);
    ss_fem_pass points = point_pass(hybrid);
    hybrid->kernels->place(&pass);
    hybrid->kernels->strain(&pass);
    clear_stress(hybrid->stress, hybrid->point_count);
    points.x = hybrid->gradient + 4;
    points.out = hybrid->stress;
    hybrid->law->tangent(&points);
    for (int32_t k = 0; k < hybrid->near_rows.count; ++k) {
        ss_real *state = hybrid->state + 8 * (ptrdiff_t)k;
        memcpy(state, state + 4, 4 * sizeof *state);
    }
    for (ptrdiff_t c = 8; c < 8 * (ptrdiff_t)(1 + 3 * hybrid->point_count); c += 8) {
        for (int a = 0; a < 3; ++a) {
            hybrid->stress[c + a] = -hybrid->stress[c + a];
        }
    }
    pass.gradient += 4;
    (void)hybrid->kernels->push(&pass, false, false);
    if (hybrid->cohesion > 0.0) {
        add_cohesion_tangent(hybrid);
    }
    for (int32_t k = 0; k < hybrid->near_rows.count; ++k) {
        ss_real *f = hybrid->particle_force + 4 * (ptrdiff_t)k;
        for (int a = 0; a < 3; ++a) {
            f[a] = -f[a];
        }
    }
    hybrid->kernels->give(&pass);
}

/* V (lambda + 4 mu)/3 |grad N|^2, the mean over the axes of an element's own stiffness at rest; of
 * a point with a residual, about that of a cube of its volume. */
void ss_hybrid_diagonal(void *owner, double *diagonal)
{
    ss_hybrid *hybrid = owner;
    const ss_mesh *mesh = hybrid->mesh;
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        const ptrdiff_t b = hybrid->lane[e] / SS_FEM_LANES;
        const int l = hybrid->lane[e] % SS_FEM_LANES;
        const ss_real *shape = hybrid->core.shape + b * SS_FEM_SHAPES * SS_FEM_LANES + l;
        const double modulus =
            hybrid->volume[e] * (hybrid->material.lambda[e] + 4.0 * hybrid->material.mu[e]) / 3.0;
        double first[3] = {0.0, 0.0, 0.0};
        for (int a = 0; a < 3; ++a) {
            double square = 0.0;
            for (int k = 0; k < 3; ++k) {
                const double g = (double)shape[SS_FEM_LANES * (3 * a + k)];
                first[k] -= g;
                square += g * g;
            }
            diagonal[mesh->tetrahedron[e][a + 1]] += modulus * square;
        }
        diagonal[mesh->tetrahedron[e][0]] +=
            modulus * (first[0] * first[0] + first[1] * first[1] + first[2] * first[2]);
    }
    for (int32_t c = 0; c < hybrid->cells.count; ++c) {
        const double modulus =
            hybrid->cell_volume[c] * (hybrid->cell_lambda[c] + 4.0 * hybrid->cell_mu[c]) / 3.0;
        for (ptrdiff_t t = hybrid->cells.first[c]; t < hybrid->cells.first[c + 1]; ++t) {
            const ss_real *row = hybrid->cells.row + 4 * t;
            diagonal[hybrid->cells.node[t]] +=
                modulus * (double)(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
        }
    }
    for (int32_t k = 0; k < hybrid->point_count; ++k) {
        const int32_t p = hybrid->point[k];
        const int32_t e = hybrid->layer->host[p];
        const double d = hybrid->layer->spacing[p];
        const double stiffness = (double)hybrid->particle[p].blend * hybrid->layer->volume[p] *
                                 (hybrid->material.lambda[e] + 4.0 * hybrid->material.mu[e]) /
                                 (d * d);
        if (hybrid->node_of[p] >= 0) {
            diagonal[hybrid->node_of[p]] += stiffness;
        }
    }
}

/* ---- ties ---- */

void ss_hybrid_tied(const ss_hybrid *hybrid, int32_t p, const ss_real *u, double out[3])
{
    const ss_layer *layer = hybrid->layer;
    out[0] = out[1] = out[2] = 0.0;
    for (int32_t t = layer->tie_first[p]; t < layer->tie_first[p + 1]; ++t) {
        for (int a = 0; a < 3; ++a) {
            out[a] += (double)layer->tie[t] * (double)u[4 * (ptrdiff_t)layer->tie_node[t] + a];
        }
    }
}

/* ---- the path, and the pair curve ---- */

SS_KERNEL_PATHS(ss_layer_kernels)

double ss_layer_pair_potential(double s, double *out_slope)
{
    const double at = fmin(fmax(s, SS_LAYER_CORE), SS_LAYER_TAIL);
    const double inverse = 1.0 / at;
    const double square = inverse * inverse;
    const double slope = 1.5 * (square - square * square);
    const double bend =
        s < SS_LAYER_CORE ? -3.0 * square * inverse + 6.0 * square * square * inverse : 0.0;
    const double beyond = s - at;
    *out_slope = slope + bend * beyond;
    return 0.5 * inverse * (square - 3.0) + slope * beyond + 0.5 * bend * beyond * beyond;
}
