/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/accuracy/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/accuracy/models.h"
#include "bench/accuracy/refine.h"
#include "bench/core/report.h"
#include "case/norms.h"
#include "case/run.h"
#include "case/scratch.h"
#include "models/model.h"
#include "output.h"
#include "rt/memory.h"
#include "rt/progress.h"
#include "rt/vec.h"
#include "scene/scene.h"
#include "world/world.h"

enum { MAX_MESHES = 3, LEVELS = 2, MOST_NODES = 120000, QUICK_NODES = 12000, LONG_PATH = 1200 };
static const double level_share[LEVELS] = {0.5, 1.0};
static const char *const level_tag[LEVELS] = {"half", "full"};
static const char reference_model[] = "fem", case_name[] = "scene";
static const double step_s = 1e-3, longest_cpu_s = 600.0, damping_share = 1.4;
static const double assumed_ratio = 2.0, least_ratio = 1.5, most_ratio = 4.5;

typedef struct maker {
    const char *path, *folder;
    char temporary[SS_SCRATCH_PATH]; /* for runs: others may make the same reference */
    ss_scene *scene;
    const ss_model_class *class;
    ss_case c;
    ss_case_body body[MAX_MESHES];
    int32_t body_count;
    double (*u[MAX_MESHES][LEVELS])[3];
    double force[MAX_MESHES][LEVELS];
    double full; /* the level that is the scene's own */
    double omega;
    softsim_verdict worst; /* of all runs */
    char verdict[320];     /* of the worst run; "" while all are good and have settled */
    ss_accuracy_worth *worth;
    softsim_error *error;
} maker;

static softsim_status refuse(maker *m, const char *why)
{
    softsim_error_add(m->error, SOFTSIM_ERROR_SCENE, "%s: %s", m->path, why);
    return SOFTSIM_ERROR_SCENE;
}

static softsim_status no_memory(maker *m)
{
    return ss_memory_fault(m->error);
}

/* ---- the scene as a case ---- */

/* NaN: the model has no such row, or it is not given. */
static double parameter(const maker *m, const char *name)
{
    for (int32_t i = 0; i < m->class->row_count; ++i) {
        if (strcmp(m->class->row[i].name, name) == 0 && m->scene->param[i].per_node == NULL) {
            return m->scene->param[i].number;
        }
    }
    return (double)NAN;
}

/* The name of a choice: the k-th of "a|b|c". */
static void choice_name(const char *choices, int32_t k, char *out, size_t size)
{
    for (; k > 0 && choices != NULL; --k) {
        choices = strchr(choices, '|');
        choices = choices != NULL ? choices + 1 : NULL;
    }
    if (choices != NULL) {
        snprintf(out, size, "%.*s", (int)strcspn(choices, "|"), choices);
    }
}

static softsim_status take_material(maker *m)
{
    ss_case *c = &m->c;
    double e = parameter(m, "youngs_modulus_pa"), nu = parameter(m, "poisson_ratio");
    const double lambda = parameter(m, "lame_lambda_pa"), mu = parameter(m, "lame_mu_pa");
    if (isnan(e) && lambda >= 0.0 && mu > 0.0) {
        e = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
        nu = 0.5 * lambda / (lambda + mu);
    }
    if (!(e > 0.0) || isnan(nu)) {
        return refuse(m, "its model has no uniform youngs_modulus_pa and poisson_ratio (or lame_*) "
                         "to make a reference of; give it such a model, as fem");
    }
    c->youngs_modulus = e;
    c->poisson_ratio = nu;
    c->density = parameter(m, "density_kg_m3");
    char name[32] = "stvk";
    for (int32_t i = 0; i < m->class->row_count; ++i) {
        if (strcmp(m->class->row[i].name, "material") == 0) {
            choice_name(m->class->row[i].choices, (int32_t)m->scene->param[i].number, name,
                        sizeof name);
        }
    }
    /* The guard of stvk-guarded never acts where a reference exists. */
    snprintf(c->material[0], sizeof c->material[0], "%s",
             strcmp(name, "neo-hookean") == 0    ? "nh"
             : strcmp(name, "stvk-guarded") == 0 ? "stvk"
                                                 : name);
    c->material_count = 1;
    return SOFTSIM_OK;
}

static softsim_status take_push(maker *m)
{
    const ss_scene_prescribed *p = m->scene->prescribed;
    ss_case_body *b = &m->body[0];
    double longest = 0.0;
    if (m->scene->prescribed_count > 1 || !p->axis[0] || !p->axis[1] || !p->axis[2]) {
        return refuse(m, "--scene takes one prescribed set, held along all axes");
    }
    b->pushed = calloc((size_t)p->node_count, sizeof *b->pushed);
    b->profile = calloc((size_t)p->node_count, sizeof *b->profile);
    if (b->pushed == NULL || b->profile == NULL) {
        return no_memory(m);
    }
    for (int32_t i = 0; i < p->node_count; ++i) {
        if (ss_norm3(p->displacement[i]) > longest) {
            longest = ss_norm3(p->displacement[i]);
            ss_scale3(m->c.direction, p->displacement[i], 1.0 / longest);
        }
    }
    for (int32_t i = 0; i < p->node_count && longest > 0.0; ++i) {
        const double along = ss_dot3(p->displacement[i], m->c.direction);
        double side[3];
        ss_madd3(side, p->displacement[i], -along, m->c.direction);
        if (ss_norm3(side) > 1e-6 * longest) {
            return refuse(m, "--scene takes a prescribed set that moves along one direction");
        }
        b->pushed[b->pushed_count] = p->node[i];
        b->profile[b->pushed_count++] = along / longest;
    }
    m->full = longest;
    snprintf(m->c.pushed, sizeof m->c.pushed, "pushed");
    snprintf(m->c.profile, sizeof m->c.profile, "pushed_profile");
    return longest > 0.0 ? SOFTSIM_OK : refuse(m, "its prescribed displacements are all zero");
}

static softsim_status take_pressure(maker *m)
{
    const ss_load *load = m->scene->load;
    ss_case_body *b = &m->body[0];
    if (m->scene->load_count > 1 || !load->is_pressure) {
        return refuse(m, "a force on nodes has no limit as the mesh is refined; --scene takes one "
                         "pressure, one prescribed set, or gravity");
    }
    b->pressed = calloc((size_t)load->node_count, sizeof *b->pressed);
    if (b->pressed == NULL) {
        return no_memory(m);
    }
    memcpy(b->pressed, load->node, (size_t)load->node_count * sizeof *b->pressed);
    b->pressed_count = load->node_count;
    m->full = load->pressure;
    snprintf(m->c.pressed, sizeof m->c.pressed, "pressed");
    return m->full != 0.0 ? SOFTSIM_OK : refuse(m, "its pressure is zero");
}

static softsim_status take_loads(maker *m)
{
    const bool has_gravity = ss_norm3(m->scene->gravity) > 0.0;
    const bool has_load = m->scene->load_count > 0, has_push = m->scene->prescribed_count > 0;
    if ((int)has_gravity + (int)has_load + (int)has_push != 1) {
        return refuse(m, "--scene takes exactly one of: a prescribed set, a pressure, gravity");
    }
    if (has_gravity) {
        ss_copy3(m->c.gravity, m->scene->gravity);
        m->full = 1.0;
        return SOFTSIM_OK;
    }
    return has_push ? take_push(m) : take_pressure(m);
}

static softsim_status take_body(maker *m)
{
    const ss_mesh *mesh = m->scene->mesh;
    ss_case_body *b = &m->body[0];
    const size_t n = (size_t)mesh->node_count;
    m->body_count = 1;
    b->fixed = calloc(n, sizeof *b->fixed);
    b->number = calloc(n, sizeof *b->number);
    b->weight = calloc(n, sizeof *b->weight);
    if (b->fixed == NULL || b->number == NULL || b->weight == NULL) {
        return no_memory(m);
    }
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        b->number[i] = i + 1;
        if (m->scene->fixed[i] != 0 && m->scene->fixed[i] != 7) {
            return refuse(m, "--scene takes nodes that are fixed along all axes");
        }
        if (m->scene->fixed[i] == 7) {
            b->fixed[b->fixed_count++] = i;
        }
    }
    if (b->fixed_count == 0) {
        return refuse(m, "nothing is fixed, so the body does not come to rest");
    }
    snprintf(m->c.fixed, sizeof m->c.fixed, "fixed");
    const softsim_status status = ss_mesh_create(
        mesh->node_count, (const double(*)[3])mesh->position, 0, NULL, mesh->tetrahedron_count,
        (const int32_t(*)[4])mesh->tetrahedron, &b->mesh, m->error);
    if (status == SOFTSIM_OK) {
        ss_refine_volumes(b->mesh, b->weight);
    }
    return status;
}

static softsim_status read_scene(maker *m)
{
    ss_scene_model models[SS_MAX_MODELS];
    const int32_t count = ss_world_scene_models(models);
    softsim_status status =
        ss_scene_load(m->path, NULL, 0, models, count, NULL, &m->scene, m->error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    m->class = ss_model_find(m->scene->model_name);
    if (m->scene->mesh->tetrahedron_count == 0) {
        return refuse(m, "its mesh is a surface; a reference needs tetrahedra "
                         "(softsim-mesh tetrahedralize)");
    }
    if (ss_model_find(reference_model) == NULL) {
        return refuse(m, "this program was built without fem, which makes the reference");
    }
    status = take_material(m);
    status = status == SOFTSIM_OK ? take_loads(m) : status;
    status = status == SOFTSIM_OK ? take_body(m) : status;
    for (int k = 0; k < LEVELS; ++k) {
        ss_case_level *level = &m->c.level[k];
        *level = (ss_case_level){.value = level_share[k] * m->full, .force = (double)NAN};
        snprintf(level->tag, sizeof level->tag, "%s", level_tag[k]);
    }
    m->c.level_count = LEVELS;
    return status;
}

/* A problem at rest is what is left of a scene. */
static void tell_taken(const maker *m)
{
    const ss_case *c = &m->c;
    int tools = 0;
    for (int p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        tools += m->scene->tool[p].is_used;
    }
    snprintf(m->worth->taken, sizeof m->worth->taken,
             "taken from the scene: mesh, supports, %s, and of its %s Young's modulus %.6g Pa, "
             "Poisson's ratio %.6g, density and the material '%s'; not taken: damping, which is "
             "each run's own, all else of the model, simulation, haptic%s",
             ss_norm3(c->gravity) > 0.0    ? "gravity"
             : m->body[0].pushed_count > 0 ? "the prescribed set"
                                           : "the pressure",
             m->class->name, c->youngs_modulus, c->poisson_ratio, c->material[0],
             tools > 0 ? ", contact.tools" : "");
    fprintf(stderr, "%s: %s\n", m->path, m->worth->taken);
}

/* ---- the reference ---- */

static softsim_status refine_bodies(maker *m, int32_t most)
{
    softsim_status status = SOFTSIM_OK;
    while (status == SOFTSIM_OK && m->body_count < MAX_MESHES) {
        const ss_case_body *last = &m->body[m->body_count - 1];
        /* About a node an edge, and a little more than an edge a tetrahedron. */
        const double next = last->mesh->node_count + 1.25 * last->mesh->tetrahedron_count;
        if (next > most) {
            break;
        }
        status = ss_refine(last, &m->body[m->body_count], m->error);
        ++m->body_count;
    }
    if (status == SOFTSIM_OK && m->body_count < 2) {
        return refuse(m, "its mesh is too fine to be refined here; give a coarser one");
    }
    return status;
}

static softsim_status run_level(maker *m, int32_t mesh, int32_t level, char *text)
{
    ss_progress_stage("reference %d of %d: %d nodes at the %s load", LEVELS * mesh + level + 1,
                      LEVELS * m->body_count, m->body[mesh].mesh->node_count, level_tag[level]);
    ss_static_run run = {.u = NULL};
    const ss_static_plan plan = {.c = &m->c,
                                 .body = &m->body[mesh],
                                 .folder = m->temporary,
                                 .model = text,
                                 .level = m->c.level[level].value,
                                 .omega = m->omega,
                                 .step_s = step_s,
                                 .longest_cpu_s = longest_cpu_s};
    softsim_status status = ss_static_execute(&plan, &run, m->error);
    if (status == SOFTSIM_OK && (!run.is_good || run.ended >= SOFTSIM_VERDICT_DEGRADED)) {
        softsim_error_add(
            m->error, SOFTSIM_ERROR_SCENE,
            "%s: no reference on %d nodes at the %s load: %s; give a smaller load, or "
            "another material",
            m->path, m->body[mesh].mesh->node_count, level_tag[level], run.verdict);
        status = SOFTSIM_ERROR_SCENE;
    }
    m->worth->unsettled = fmax(m->worth->unsettled, run.left);
    if (strcmp(run.verdict, "good") != 0 && (m->verdict[0] == '\0' || run.worst > m->worst)) {
        m->worst = run.worst;
        snprintf(m->verdict, sizeof m->verdict, "%s", run.verdict);
    }
    m->u[mesh][level] = run.u;
    m->force[mesh][level] = ss_dot3(run.force, m->c.direction);
    return status;
}

/* The model's lines, with a mass damping (0: to be measured). */
static char *model_text(maker *m, const ss_hints_body *size, double damping)
{
    const ss_model_class *model = ss_accuracy_model_find(reference_model);
    const ss_hints_setting setting = {.body = size,
                                      .material =
                                          ss_accuracy_model_material(model, m->c.material[0]),
                                      .scale = 1.0,
                                      .damping = damping};
    return ss_accuracy_model_text(model, &setting, NULL);
}

static softsim_status solve(maker *m)
{
    const ss_hints_body size = ss_accuracy_body_of(&m->c, m->body[0].mesh);
    char *text = model_text(m, &size, 0.0);
    softsim_status status =
        text == NULL ? no_memory(m) : ss_static_prepare(&m->body[0], m->temporary, m->error);
    if (status == SOFTSIM_OK) {
        const ss_static_plan plan = {.c = &m->c,
                                     .body = &m->body[0],
                                     .folder = m->temporary,
                                     .model = text,
                                     .level = m->full,
                                     .step_s = step_s,
                                     .longest_cpu_s = longest_cpu_s};
        ss_progress_stage("how fast the body of %d nodes moves", m->body[0].mesh->node_count);
        status = ss_static_measure(&plan, &m->omega, m->error);
    }
    free(text);
    if (status == SOFTSIM_OK && isnan(m->omega)) {
        return refuse(m, "its load moves nothing, or fem refuses it");
    }
    text = model_text(m, &size, damping_share * m->omega);
    status = status == SOFTSIM_OK && text == NULL ? no_memory(m) : status;
    for (int32_t k = 0; k < m->body_count && status == SOFTSIM_OK; ++k) {
        status = ss_static_prepare(&m->body[k], m->temporary, m->error);
        for (int32_t l = 0; l < LEVELS && status == SOFTSIM_OK; ++l) {
            status = run_level(m, k, l, text);
        }
    }
    free(text);
    return status;
}

/* Judged at the full level. */
static void judge(maker *m)
{
    ss_accuracy_worth *w = m->worth;
    const ss_case_body *b = &m->body[0];
    const int32_t full = LEVELS - 1, last = m->body_count - 1;
    for (int k = 0; k < 2; ++k) {
        w->change[k] = k < last ? ss_norms_apart(b->mesh->node_count, b->weight,
                                                 (const double(*)[3])m->u[k][full],
                                                 (const double(*)[3])m->u[k + 1][full])
                                : (double)NAN;
    }
    w->nodes = m->body[last].mesh->node_count;
    const bool is_measured = last == 2;
    const double seen = is_measured ? w->change[0] / w->change[1] : assumed_ratio;
    const bool is_falling = seen >= least_ratio;
    w->ratio = fmin(fmax(seen, least_ratio), most_ratio);
    const double correction = w->change[last - 1] / (w->ratio - 1.0);
    w->left = correction + w->unsettled * (w->ratio + 1.0) / (w->ratio - 1.0);
    const size_t size = sizeof w->text;
    int used = snprintf(w->text, size,
                        "The reference is fem on the scene's mesh refined %d time%s, %d nodes, "
                        "corrected by what the meshes show. From mesh to mesh the field changed by "
                        "%.2g",
                        last, last > 1 ? "s" : "", w->nodes, w->change[0]);
    if (is_measured) {
        used += snprintf(w->text + used, size - (size_t)used, " and %.2g", w->change[1]);
    }
    used +=
        snprintf(w->text + used, size - (size_t)used,
                 " of itself; %s, and the correction is %.2g of the field. Of the least settled "
                 "run about %.2g of the field is missing. The reference is worth both: errors "
                 "below %.2g mean nothing.%s",
                 !is_measured ? "how it falls is assumed"
                 : is_falling ? "it falls as it should"
                              : "it does not fall as it should",
                 correction, w->unsettled, w->left,
                 is_measured && !is_falling
                     ? " The changes hardly fall: this problem has no limit that these meshes "
                       "reach."
                     : "");
    if (m->verdict[0] != '\0') {
        snprintf(w->text + used, size - (size_t)used, " Not all of its runs were good: %s.",
                 m->verdict);
    }
}

/* ---- files ---- */

static softsim_status open_file(const maker *m, const char *name, int32_t mesh, const char *end,
                                ss_output *output)
{
    char path[LONG_PATH];
    snprintf(path, sizeof path, "%s/%s_%d%s", m->folder, name, mesh, end);
    return ss_output_open(output, path, m->error);
}

static void put_set(FILE *file, const char *name, int32_t count, const int32_t *node,
                    const double *value)
{
    fprintf(file, "\"%s\":[", name);
    for (int32_t i = 0; i < count; ++i) {
        fprintf(file, "%s%d", i > 0 ? "," : "", node[i] + 1);
    }
    fputc(']', file);
    if (value != NULL) {
        fprintf(file, ",\"%s_profile\":[", name);
        for (int32_t i = 0; i < count; ++i) {
            fprintf(file, "%s%.17g", i > 0 ? "," : "", value[i]);
        }
        fputc(']', file);
    }
}

static softsim_status write_sets(const maker *m, int32_t mesh)
{
    const ss_case_body *b = &m->body[mesh];
    ss_output output;
    const softsim_status status = open_file(m, "nodesets", mesh, ".json", &output);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputc('{', output.file);
    put_set(output.file, "fixed", b->fixed_count, b->fixed, NULL);
    if (b->pushed_count > 0) {
        fputc(',', output.file);
        put_set(output.file, "pushed", b->pushed_count, b->pushed, b->profile);
    }
    if (b->pressed_count > 0) {
        fputc(',', output.file);
        put_set(output.file, "pressed", b->pressed_count, b->pressed, NULL);
    }
    fputs("}\n", output.file);
    return ss_output_commit(&output, m->error);
}

static softsim_status write_surface(const maker *m, int32_t mesh)
{
    const ss_mesh *at = m->body[mesh].mesh;
    ss_output output;
    const softsim_status status = open_file(m, "surface", mesh, ".obj", &output);
    if (status != SOFTSIM_OK) {
        return status;
    }
    for (int32_t i = 0; i < at->node_count; ++i) {
        fprintf(output.file, "v %.17g %.17g %.17g # node %d\n", at->position[i][0],
                at->position[i][1], at->position[i][2], i + 1);
    }
    for (int32_t t = 0; t < at->triangle_count; ++t) {
        fprintf(output.file, "f %d %d %d\n", at->triangle[t][0] + 1, at->triangle[t][1] + 1,
                at->triangle[t][2] + 1);
    }
    return ss_output_commit(&output, m->error);
}

/* u_n + (u_n - u_{n-1})/(r - 1), where the last mesh but one has the node. */
static softsim_status write_reference(const maker *m, int32_t mesh)
{
    const ss_case_body *b = &m->body[mesh];
    const int32_t last = m->body_count - 1;
    ss_output output;
    const softsim_status status = open_file(m, "reference", mesh, ".csv", &output);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("node,x,y,z,w", output.file);
    for (int l = 0; l < LEVELS; ++l) {
        fprintf(output.file, ",ux_%s,uy_%s,uz_%s", level_tag[l], level_tag[l], level_tag[l]);
    }
    fputc('\n', output.file);
    for (int32_t i = 0; i < b->mesh->node_count; ++i) {
        const double *x = b->mesh->position[i];
        fprintf(output.file, "%d,%.9g,%.9g,%.9g,%.9g", i + 1, x[0], x[1], x[2], b->weight[i]);
        for (int l = 0; l < LEVELS; ++l) {
            for (int k = 0; k < 3; ++k) {
                const double fine = m->u[last][l][i][k], coarse = m->u[last - 1][l][i][k];
                fprintf(output.file, ",%.9g", fine + (fine - coarse) / (m->worth->ratio - 1.0));
            }
        }
        fputc('\n', output.file);
    }
    return ss_output_commit(&output, m->error);
}

static softsim_status write_mesh(const maker *m, int32_t mesh)
{
    char path[LONG_PATH];
    snprintf(path, sizeof path, "%s/mesh_%d.msh", m->folder, mesh);
    softsim_status status = ss_mesh_write_msh(m->body[mesh].mesh, path, m->error);
    status = status == SOFTSIM_OK ? write_surface(m, mesh) : status;
    status = status == SOFTSIM_OK ? write_sets(m, mesh) : status;
    return status == SOFTSIM_OK ? write_reference(m, mesh) : status;
}

static softsim_status write_forces(const maker *m)
{
    char path[LONG_PATH];
    ss_output output;
    const int32_t last = m->body_count - 1;
    snprintf(path, sizeof path, "%s/force.csv", m->folder);
    const softsim_status status = ss_output_open(&output, path, m->error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    fputs("material,depth_m,Fx_N,Fy_N,Fz_N\n", output.file);
    for (int l = 0; l < LEVELS; ++l) {
        const double fine = m->force[last][l];
        const double force = fine + (fine - m->force[last - 1][l]) / (m->worth->ratio - 1.0);
        fprintf(output.file, "%s,%.17g,%.9g,%.9g,%.9g\n", m->c.material[0], m->c.level[l].value,
                force * m->c.direction[0], force * m->c.direction[1], force * m->c.direction[2]);
    }
    return ss_output_commit(&output, m->error);
}

static void put_statement(const maker *m, FILE *file)
{
    const ss_case *c = &m->c;
    fprintf(file, "case: %s\nkind: static\nmaterial: {youngs_modulus_pa: %.9g, poisson_ratio: %.9g",
            case_name, c->youngs_modulus, c->poisson_ratio);
    if (!isnan(c->density)) {
        fprintf(file, ", density_kg_m3: %.9g", c->density);
    }
    fputs("}\nfixed: fixed\n", file);
    if (m->body[0].pushed_count > 0) {
        fprintf(file,
                "prescribed: {set: pushed, direction: [%.17g, %.17g, %.17g], profile: "
                "pushed_profile}\nforce: force.csv\n",
                c->direction[0], c->direction[1], c->direction[2]);
    }
    if (m->body[0].pressed_count > 0) {
        fputs("pressure: {set: pressed}\n", file);
    }
    if (ss_norm3(c->gravity) > 0.0) {
        fprintf(file, "gravity_m_s2: [%.9g, %.9g, %.9g]\n", c->gravity[0], c->gravity[1],
                c->gravity[2]);
    }
    fprintf(file, "levels: {%s: {%s: %.17g, %s: %.17g}}\nmeshes:\n", c->material[0], level_tag[0],
            c->level[0].value, level_tag[1], c->level[1].value);
    for (int32_t k = 0; k + 1 < m->body_count; ++k) {
        fprintf(file,
                "  \"%s\": {volume: mesh_%d.msh, surface: surface_%d.obj, sets: nodesets_%d.json, "
                "reference: {%s: reference_%d.csv}}\n",
                k == 0 ? "own" : "refined", k, k, k, c->material[0], k);
    }
}

static softsim_status write_case(const maker *m)
{
    char path[LONG_PATH];
    ss_output output;
    softsim_status status = m->body[0].pushed_count > 0 ? write_forces(m) : SOFTSIM_OK;
    for (int32_t k = 0; k + 1 < m->body_count && status == SOFTSIM_OK; ++k) {
        status = write_mesh(m, k);
    }
    snprintf(path, sizeof path, "%s/case.yaml", m->folder);
    if (status == SOFTSIM_OK) {
        status = ss_output_open(&output, path, m->error);
    }
    if (status != SOFTSIM_OK) {
        return status;
    }
    put_statement(m, output.file);
    return ss_output_commit(&output, m->error);
}

void ss_accuracy_scene_outline(ss_case *out)
{
    static const char *const materials[] = {"linear", "stvk", "nh"};
    *out = (ss_case){.material_count = (int32_t)(sizeof materials / sizeof *materials)};
    snprintf(out->name, sizeof out->name, "%s", case_name);
    for (int32_t i = 0; i < out->material_count; ++i) {
        snprintf(out->material[i], sizeof out->material[i], "%s", materials[i]);
        for (int k = 0; k < LEVELS; ++k) {
            ss_case_level *level = &out->level[out->level_count++];
            level->material = i;
            snprintf(level->tag, sizeof level->tag, "%s", level_tag[k]);
        }
    }
}

/* ---- the whole ---- */

softsim_status ss_accuracy_scene(const char *scene, const char *folder, bool is_quick,
                                 ss_accuracy_worth *out, softsim_error *error)
{
    maker *m = calloc(1, sizeof *m);
    if (m == NULL) {
        return ss_memory_fault(error);
    }
    *m = (maker){.path = scene, .folder = folder, .worth = out, .error = error};
    *out = (ss_accuracy_worth){.nodes = 0};
    softsim_status status = ss_scratch_make("softsim-accuracy", m->temporary, error);
    status = status == SOFTSIM_OK ? read_scene(m) : status;
    if (status == SOFTSIM_OK) {
        tell_taken(m);
        ss_progress_begin("softsim-bench accuracy", "refining the mesh of %s", m->path);
        status = refine_bodies(m, is_quick ? QUICK_NODES : MOST_NODES);
    }
    if (status == SOFTSIM_OK) { /* before the long work, not before the scene is known to be one */
        status = ss_report_make_folder(folder, error);
    }
    if (status == SOFTSIM_OK) {
        status = solve(m);
    }
    if (status == SOFTSIM_OK) {
        judge(m);
        status = write_case(m);
    }
    ss_progress_end();
    for (int32_t k = 0; k < MAX_MESHES; ++k) {
        for (int32_t l = 0; l < LEVELS; ++l) {
            free(m->u[k][l]);
        }
        ss_case_body_fini(&m->body[k]);
    }
    ss_scene_destroy(&m->scene);
    ss_scratch_remove(m->temporary);
    free(m);
    return status;
}
