/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "world/field.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "models/tissue_law.h"
#include "rt/each.h"
#include "rt/memory.h"
#include "rt/vec.h"

/* A tetrahedron at rest: H = sum_k u_k gradient_k. */
typedef struct element {
    double gradient[4][3]; /* of the shape functions, 1/m */
    double volume;         /* m^3 */
    ss_tissue_law law;
} element;

struct ss_field {
    const ss_mesh *mesh;   /* borrowed */
    const ss_drawn *drawn; /* borrowed */
    element *element;      /* NULL: only displacements are possible */
    double *volume;        /* a node: of its tetrahedra together, m^3 */
    double *sum;           /* scratch, a node */
};

const char *ss_field_name(ss_scene_field kind)
{
    static const char *const name[] = {"none", "displacement", "energy", "pressure", "potential"};
    return name[kind];
}

const char *ss_field_unit(ss_scene_field kind)
{
    static const char *const unit[] = {"", "m", "J/m^3", "Pa", "J"};
    return unit[kind];
}

/* Row of a model's parameter; -1. */
static int find_row(const ss_model_class *model, const char *name)
{
    const ss_param_row *row = ss_model_find_row(model, name);
    return row != NULL ? (int)(row - model->row) : -1;
}

bool ss_field_is_possible(const ss_scene *scene, const ss_model_class *model, ss_scene_field kind)
{
    switch (kind) {
    case SS_SCENE_FIELD_ENERGY:
    case SS_SCENE_FIELD_PRESSURE:
        return scene->mesh->tetrahedron_count > 0 && find_row(model, "youngs_modulus_pa") >= 0;
    case SS_SCENE_FIELD_POTENTIAL:
        return model->potential != NULL;
    default:
        return true;
    }
}

const char *ss_field_lack(ss_scene_field kind)
{
    return kind == SS_SCENE_FIELD_POTENTIAL ? "no potential of its own, as cnn-energy's cells have"
                                            : "no tetrahedra with elastic moduli";
}

void ss_field_list(const ss_scene *scene, const ss_model_class *model, const char *between,
                   char *out, size_t size)
{
    size_t length = 0;
    out[0] = '\0';
    for (int k = SS_SCENE_FIELD_NONE; k <= SS_SCENE_FIELD_POTENTIAL; ++k) {
        if (ss_field_is_possible(scene, model, (ss_scene_field)k) && length < size) {
            length += (size_t)snprintf(out + length, size - length, "%s%s",
                                       length > 0 ? between : "", ss_field_name((ss_scene_field)k));
        }
    }
}

/* The scene's law, or St. Venant-Kirchhoff where the model's is none of the list: what corotational
 * calls linear turns with the body. */
static ss_tissue_kind read_law(const ss_scene *scene, const ss_model_class *model)
{
    const int row = find_row(model, "material");
    const char *at = row >= 0 ? model->row[row].choices : "";
    for (int i = row >= 0 ? (int)scene->param[row].number : 0; i > 0; --i) {
        at += strcspn(at, "|");
        at += *at == '|';
    }
    const bool is_whole = row >= 0 && strcmp(model->row[row].choices, SS_TISSUE_CHOICES) == 0;
    for (int k = 0; k < (is_whole ? SS_TISSUE_KIND_COUNT : SS_TISSUE_LINEAR); ++k) {
        const char *name = ss_tissue_name((ss_tissue_kind)k);
        if (strlen(name) == strcspn(at, "|") && strncmp(name, at, strlen(name)) == 0) {
            return (ss_tissue_kind)k;
        }
    }
    return SS_TISSUE_STVK;
}

/* Gradients from the inverse of the edges; false for a flat one. */
static bool fill_shape(const ss_mesh *mesh, int32_t e, element *out)
{
    const int32_t *corner = mesh->tetrahedron[e];
    double edge[3][3], area[3][3];
    for (int k = 0; k < 3; ++k) {
        ss_sub3(edge[k], mesh->position[corner[k + 1]], mesh->position[corner[0]]);
    }
    ss_cross3(area[0], edge[1], edge[2]);
    ss_cross3(area[1], edge[2], edge[0]);
    ss_cross3(area[2], edge[0], edge[1]);
    const double six = ss_dot3(edge[0], area[0]);
    out->volume = fabs(six) / 6.0;
    if (!(out->volume > 0.0)) {
        return false;
    }
    for (int d = 0; d < 3; ++d) {
        for (int k = 0; k < 3; ++k) {
            out->gradient[k + 1][d] = area[k][d] / six;
        }
        out->gradient[0][d] = -(out->gradient[1][d] + out->gradient[2][d] + out->gradient[3][d]);
    }
    return true;
}

static void fill_law(const ss_scene *scene, const ss_model_class *model, int32_t e, element *out)
{
    const ss_model_plan plan = {.mesh = scene->mesh, .param = scene->param};
    const int young = find_row(model, "youngs_modulus_pa"),
              ratio = find_row(model, "poisson_ratio");
    const int lambda = find_row(model, "lame_lambda_pa"), mu = find_row(model, "lame_mu_pa");
    if (ratio < 0) { /* springs: Poisson's ratio near 1/4, whatever is asked for */
        ss_tissue_lame(ss_plan_element_value(&plan, young, e), 0.25, &out->law.lambda,
                       &out->law.mu);
    } else if (lambda < 0 || scene->param[young].is_given) {
        ss_tissue_lame(ss_plan_element_value(&plan, young, e),
                       ss_plan_element_value(&plan, ratio, e), &out->law.lambda, &out->law.mu);
    } else {
        out->law.lambda = ss_plan_element_value(&plan, lambda, e);
        out->law.mu = ss_plan_element_value(&plan, mu, e);
    }
}

void ss_field_destroy(ss_field **field)
{
    if (*field != NULL) {
        SS_EACH(ss_memory_free, (*field)->element, (*field)->volume, (*field)->sum, *field);
        *field = NULL;
    }
}

ss_field *ss_field_create(const ss_scene *scene, const ss_model_class *model, const ss_drawn *drawn)
{
    ss_field *field = ss_memory_get(1, sizeof *field);
    if (field == NULL) {
        return NULL;
    }
    field->mesh = scene->mesh;
    field->drawn = drawn;
    if (!ss_field_is_possible(scene, model, SS_SCENE_FIELD_ENERGY)) {
        return field;
    }
    const size_t nodes = (size_t)scene->mesh->node_count;
    field->element = ss_memory_get((size_t)scene->mesh->tetrahedron_count, sizeof *field->element);
    field->volume = ss_memory_get(nodes, sizeof *field->volume);
    field->sum = ss_memory_get(nodes, sizeof *field->sum);
    if (field->element == NULL || field->volume == NULL || field->sum == NULL) {
        ss_field_destroy(&field);
        return NULL;
    }
    const ss_tissue_kind kind = read_law(scene, model);
    for (int32_t e = 0; e < scene->mesh->tetrahedron_count; ++e) {
        element *at = &field->element[e];
        if (fill_shape(scene->mesh, e, at)) {
            fill_law(scene, model, e, at);
            at->law.kind = kind;
            for (int k = 0; k < 4; ++k) {
                field->volume[scene->mesh->tetrahedron[e][k]] += at->volume;
            }
        }
    }
    return field;
}

static void displacement_gradient(const element *e, const int32_t corner[4], const float *u,
                                  double out_h[9])
{
    memset(out_h, 0, 9 * sizeof *out_h);
    for (int k = 0; k < 4; ++k) {
        for (int i = 0; i < 9; ++i) {
            out_h[i] += (double)u[3 * (size_t)corner[k] + (size_t)(i / 3)] * e->gradient[k][i % 3];
        }
    }
}

/* -tr(P F^T) / (3 J); of an element that is turned inside out the law's own push, by rest volume.
 */
static double pressure(const ss_tissue_law *law, const double h[9])
{
    double p[9], trace = 0.0;
    ss_tissue_stress(law, h, p);
    for (int i = 0; i < 9; ++i) {
        trace += p[i] * (h[i] + (i % 4 == 0 ? 1.0 : 0.0));
    }
    const double j = 1.0 + ss_tissue_volume_change(h);
    return -trace / (3.0 * (j > 0.01 ? j : 1.0));
}

void ss_field_compute(ss_field *field, ss_scene_field kind, const float *displacement,
                      float *out_value)
{
    const ss_mesh *mesh = field->mesh;
    if (kind == SS_SCENE_FIELD_DISPLACEMENT || field->element == NULL) {
        for (int32_t i = 0; i < field->drawn->node_count; ++i) {
            const float *u = displacement + 3 * (size_t)i;
            out_value[i] = sqrtf(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        }
        return;
    }
    memset(field->sum, 0, (size_t)mesh->node_count * sizeof *field->sum);
    for (int32_t e = 0; e < mesh->tetrahedron_count; ++e) {
        const element *at = &field->element[e];
        double h[9];
        displacement_gradient(at, mesh->tetrahedron[e], displacement, h);
        const double value =
            kind == SS_SCENE_FIELD_ENERGY ? ss_tissue_energy(&at->law, h) : pressure(&at->law, h);
        for (int k = 0; k < 4 && isfinite(value); ++k) {
            field->sum[mesh->tetrahedron[e][k]] += at->volume * value;
        }
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        out_value[i] = field->volume[i] > 0.0 ? (float)(field->sum[i] / field->volume[i]) : 0.0F;
    }
    ss_drawn_spread(field->drawn, out_value);
}
