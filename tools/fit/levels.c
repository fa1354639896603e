/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "levels.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"
#include "world/world.h"

static const double longest_cpu_s = 60.0; /* of one level */
static const double ramp_phase = 3.14159265358979;

/* ---- the scene's model ---- */

static void copy_line(void *sink, const char *text)
{
    fprintf(sink, "%s\n", text);
}

/* The model's lines, the outer step, and whether the scene is a surface. */
static softsim_status read_scene(const ss_press_scene *from, ss_fit_levels *out,
                                 bool *out_on_surface, softsim_error *error)
{
    const ss_world_options options = {.scene_path = from->path,
                                      .set = from->set,
                                      .set_count = from->set_count,
                                      .is_lockstep = true};
    ss_world *world = NULL;
    const softsim_status status = ss_world_create(&options, &world, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    size_t size = 0;
    FILE *stream = open_memstream(&out->model, &size);
    if (stream) {
        ss_scene_print_given(world->scene, "model", copy_line, stream);
        fclose(stream);
    }
    out->step_s = world->step_period;
    *out_on_surface = world->scene->mesh->tetrahedron_count == 0;
    ss_lockstep_stop(world);
    ss_world_destroy(&world);
    return out->model ? SOFTSIM_OK : ss_memory_fault(error);
}

/* The model's lines with other values; to be freed. A parameter that is not among them is added. */
static char *with_values(const ss_fit_levels *levels, int32_t count,
                         const ss_fit_parameter *parameter, const double *value)
{
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    bool is_done[SS_FIT_MAX_PARAMETERS] = {false};
    for (const char *at = levels->model; stream && *at != '\0';) {
        const int length = (int)strcspn(at, "\n");
        const char *key = at + strspn(at, " ");
        const size_t name = strcspn(key, ":");
        int32_t hit = -1;
        for (int32_t i = 0; i < count; ++i) {
            const char *wanted = parameter[i].path + 6; /* behind "model." */
            hit = strlen(wanted) == name && strncmp(wanted, key, name) == 0 ? i : hit;
        }
        if (hit >= 0) {
            fprintf(stream, "  %s: %.17g\n", parameter[hit].path + 6, value[hit]);
            is_done[hit] = true;
        } else {
            fprintf(stream, "%.*s\n", length, at);
        }
        at += length + (at[length] == '\n');
    }
    for (int32_t i = 0; stream && i < count; ++i) {
        if (!is_done[i]) {
            fprintf(stream, "  %s: %.17g\n", parameter[i].path + 6, value[i]);
        }
    }
    if (stream) {
        fclose(stream);
    }
    return text;
}

/* ---- the case ---- */

static const ss_case_mesh *choose_mesh(const ss_fit_levels *levels, const char *name,
                                       bool on_surface, softsim_error *error)
{
    int32_t count = 0;
    char list[512] = "";
    size_t used = 0;
    const ss_case_mesh *mesh = ss_case_meshes(&levels->c, on_surface, &count);
    for (int32_t i = 0; i < count; ++i) {
        if (!ss_case_has_body(&mesh[i], on_surface)) {
            continue;
        }
        if (!name || strcmp(mesh[i].name, name) == 0) {
            return &mesh[i];
        }
        const int length =
            snprintf(list + used, sizeof list - used, "%s%s", used > 0 ? ", " : "", mesh[i].name);
        used = used + (size_t)length < sizeof list ? used + (size_t)length : used;
    }
    softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                      list[0] != '\0' ? "%s: no %s mesh '%s'; it has %s" : "%s: no %s mesh%s%s",
                      levels->c.folder, on_surface ? "surface" : "volume", name ? name : "", list);
    return NULL;
}

static softsim_status choose_levels(ss_fit_levels *levels, const char *material,
                                    softsim_error *error)
{
    const ss_case *c = &levels->c;
    levels->material = material ? -1 : 0;
    for (int32_t m = 0; material && m < c->material_count; ++m) {
        levels->material = strcmp(c->material[m], material) == 0 ? m : levels->material;
    }
    if (c->is_dynamic || levels->material < 0 || c->material_count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          c->is_dynamic ? "%s: a case of motion has no levels at rest to fit to%s"
                                        : "%s: no material '%s'",
                          c->folder, c->is_dynamic || !material ? "" : material);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    double sum = 0.0;
    for (int32_t k = 0; k < c->level_count; ++k) {
        if (c->level[k].material == levels->material) {
            levels->level[levels->level_count++] = k;
            sum += c->level[k].force * c->level[k].force;
        }
    }
    levels->force_rms = isfinite(sum) ? sqrt(sum / levels->level_count) : 0.0;
    return SOFTSIM_OK;
}

softsim_status ss_fit_levels_open(const char *folder, const char *material, const char *mesh,
                                  const ss_press_scene *scene, double load_s, ss_fit_levels *out,
                                  softsim_error *error)
{
    bool on_surface = false;
    *out = (ss_fit_levels){.load_s = load_s};
    softsim_status status = ss_case_load(folder, &out->c, error);
    if (status == SOFTSIM_OK) {
        status = choose_levels(out, material, error);
    }
    if (status == SOFTSIM_OK) {
        status = read_scene(scene, out, &on_surface, error);
    }
    const ss_case_mesh *chosen =
        status == SOFTSIM_OK ? choose_mesh(out, mesh, on_surface, error) : NULL;
    if (!chosen) {
        return status != SOFTSIM_OK ? status : SOFTSIM_ERROR_ARGUMENT;
    }
    out->mesh = chosen->name;
    status = ss_case_load_body(&out->c, chosen, out->material, on_surface, &out->body, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    status = ss_scratch_make("softsim-fit", out->folder, error);
    if (status != SOFTSIM_OK) {
        return status;
    }
    out->residual_count = out->level_count * (3 * out->body.mesh->node_count + 1);
    out->residual = calloc((size_t)out->residual_count, sizeof *out->residual);
    if (!out->residual) {
        return ss_memory_fault(error);
    }
    return ss_static_prepare(&out->body, out->folder, error);
}

void ss_fit_levels_close(ss_fit_levels *levels)
{
    ss_scratch_remove(levels->folder);
    ss_case_body_fini(&levels->body);
    ss_case_fini(&levels->c);
    free(levels->model);
    free(levels->residual);
}

/* ---- measuring ---- */

/* The residuals of one level, from its run; returns the square of the field's relative error. */
static double fill_level(ss_fit_levels *levels, int32_t k, const ss_static_run *run,
                         double *out_force_square)
{
    const ss_case_body *body = &levels->body;
    const int32_t level = levels->level[k], nodes = body->mesh->node_count;
    const double(*wanted)[3] = (const double(*)[3])body->reference[level];
    const bool has_force = levels->force_rms > 0.0;
    const double share = sqrt(1.0 / (levels->level_count * (has_force ? 2.0 : 1.0)));
    double *out = levels->residual + (ptrdiff_t)k * (3 * nodes + 1);
    double all = 0.0, field = 0.0;
    for (int32_t i = 0; i < nodes; ++i) {
        all += body->weight[i] * ss_dot3(wanted[i], wanted[i]);
    }
    for (int32_t i = 0; i < nodes; ++i) {
        const double weight = sqrt(body->weight[i] / all);
        for (int a = 0; a < 3; ++a) {
            const double miss = weight * (run->u[i][a] - wanted[i][a]);
            out[3 * i + a] = share * miss;
            field += miss * miss;
        }
    }
    const double force = ss_dot3(run->force, levels->c.direction);
    const double miss =
        has_force ? (force - levels->c.level[level].force) / levels->force_rms : 0.0;
    out[3 * nodes] = share * miss;
    *out_force_square = miss * miss;
    return field;
}

softsim_status ss_fit_levels_measure(ss_fit_levels *levels, int32_t count,
                                     const ss_fit_parameter *parameter, const double *value,
                                     softsim_error *error)
{
    char *model = with_values(levels, count, parameter, value);
    softsim_status status = model ? SOFTSIM_OK : ss_memory_fault(error);
    double field = 0.0, force = 0.0;
    for (int32_t k = 0; k < levels->level_count && status == SOFTSIM_OK; ++k) {
        const ss_static_plan plan = {.c = &levels->c,
                                     .body = &levels->body,
                                     .folder = levels->folder,
                                     .model = model,
                                     .level = levels->c.level[levels->level[k]].value,
                                     .omega = ramp_phase / levels->load_s,
                                     .step_s = levels->step_s,
                                     .longest_cpu_s = longest_cpu_s};
        ss_static_run run;
        status = ss_static_execute(&plan, &run, error);
        if (status == SOFTSIM_OK && !run.is_good) {
            status = SOFTSIM_ERROR_SCENE;
            softsim_error_add(error, status, "%s, level %s: %s", levels->c.name,
                              levels->c.level[levels->level[k]].tag, run.verdict);
        } else if (status == SOFTSIM_OK) {
            double square = 0.0;
            field += fill_level(levels, k, &run, &square) / levels->level_count;
            force += square / levels->level_count;
        }
        ss_static_run_fini(&run);
    }
    levels->field_misfit = sqrt(field);
    levels->force_misfit = levels->force_rms > 0.0 ? sqrt(force) : (double)NAN;
    free(model);
    return status;
}
