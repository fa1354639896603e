/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-mesh scene: a mesh and a tissue to a scene that can be felt.
 *
 * Everything that a scene needs and a mesh does not say is chosen, and the scene says why: the unit
 * by size, what is held (the side away from the hand), the tool by the size of body and edges, the
 * model by the mesh and by what it is for. Then the scene is loaded in this process and pressed
 * (trial.h): a model whose press is not good gives way to the next, unless it was asked for; and
 * one whose constants are not physical gets its forces scaled until they are those of Hertz, which
 * is exact for a network that is linear and takes a few presses for others.
 * Rejected: constants by formulas alone (a network's press depends on the mesh and the tool), and
 * a scene that was never run.
 */
#include "command.h"

#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "leftover.h"
#include "organ.h"
#include "output.h"
#include "rt/files.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/progress.h"
#include "rt/vec.h"

enum { SCALINGS = 5, MAX_MODELS = 4 };
static const double TOOL_SHARE = 0.05;   /* its radius, of the body's diagonal */
static const double FINGERTIP_M = 0.01;  /* and not larger, but for that */
static const double LARGEST_TOOL = 0.12; /* the same, where edges are long */
static const double HAND_DEPTH_M = 8e-3; /* what the simulated hand of softsim-bridge presses */
static const double DEEPEST_SHARE = 0.3; /* of the body's height */
static const double PLANNED_SHARE = 0.4; /* of a step's time: what is planned leaves out caches */
static const double LATE = 0.1;          /* of the depth: a touch is then looked for anew */
static const double CLOSE = 0.02;        /* a scaled force is this near to Hertz */
static const double LOWERED = 0.75;    /* of the largest force, at a time, while a tool sinks in */
static const double LEAST_LIMIT = 0.8; /* of the working force: it is not lowered below */

/* What is tried, in this order. */
static const char *const wanted[][MAX_MODELS] = {
    [ORGAN_FOR_FEEL] = {"fem-quadratic", "fem", "cnn-energy", NULL},
    [ORGAN_FOR_ACCURACY] = {"fem-quadratic", "fem", "corotational", "cnn-energy"},
    [ORGAN_FOR_SPEED] = {"cnn-energy", "fem", NULL, NULL},
};
/* Haptic periods of a step, at most: a hand feels less of what comes later. */
static const int32_t slowest[] = {
    [ORGAN_FOR_FEEL] = 4, [ORGAN_FOR_ACCURACY] = 10, [ORGAN_FOR_SPEED] = 2};

/* ---- arguments ---- */

static ss_args_result parse(int argc, char **argv, void *what, softsim_error *error)
{
    organ_request *q = what;
    *q = (organ_request){.units = -1, .fixed = "away"};
    const ss_arg rows[] = {
        SS_TEXT("--tissue", &q->tissue_name, "NAME", "what it is made of; --tissues lists them"),
        SS_TEXT("--out", &q->out, "ORGAN.yaml", "the scene"),
        SS_CHOICE("--units", &q->units, UNITS,
                  "of MESH (without: by size, an organ has 2 to 30 cm)"),
        SS_TEXT("--fixed", &q->fixed, "WHAT",
                "what is held: away (the side away from the hand), the name of a group of MESH,\n"
                "or an entry as a scene has it, in metres: '{box_m: [[x, y, z], [x, y, z]]}',\n"
                "'{plane: {point_m: [x, y, z], normal: [x, y, z]}}' (what lies behind it),\n"
                "'{sphere: {center_m: [x, y, z], radius_m: R}}' (away)"),
        SS_CHOICE("--for", &q->purpose, "feel|accuracy|speed", "chooses the model (feel)"),
        SS_TEXT("--model", &q->model, "NAME", "the model, whatever it is for"),
        SS_CHOICE("--from", &q->side, "+z|-z|+x|-x|+y|-y",
                  "the side that the hand comes from (+z)"),
        {"--tool-mm", SS_ARG_NUMBER, &q->tool_mm, 0.01, 1000.0, "R",
         "radius of the ball that presses (by the body's size)"},
        SS_TEXT("--preview", &q->preview, "OUT.png",
                "a picture by gnuplot: body, what is held, tool and place"),
        SS_FLAG("--tissues", &q->lists_tissues, "lists the tissues with their sources, and ends"),
    };
    int32_t count = 0;
    const ss_args_result result = ss_args_parse(
        argc, argv, "MESH --tissue NAME --out ORGAN.yaml [options]",
        "Writes a scene of a mesh that can be felt, and presses it before it is called "
        "good.\n"
        "Exit status 0: it was written, with the verdict of the press; 2: it was not.",
        rows, (int32_t)(sizeof rows / sizeof rows[0]), &q->mesh, 0, 1, &count, error);
    if (result != SS_ARGS_RUN || q->lists_tissues) {
        return result;
    }
    char names[256];
    tissue_names(names, sizeof names);
    if (count == 0) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "MESH is missing; give the file");
    }
    if (q->out == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--out is missing; give ORGAN.yaml");
    }
    if (q->tissue_name == NULL || tissue_find(q->tissue_name) == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT, "--tissue%s%.40s%s: give one of %s",
                          q->tissue_name != NULL ? ": '" : " is missing",
                          q->tissue_name != NULL ? q->tissue_name : "",
                          q->tissue_name != NULL ? "' is not known" : "", names);
    }
    if (q->model != NULL && ss_model_find(q->model) == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--model: '%.40s' is not built in; softsimd --help names those that are",
                          q->model);
    }
    const ss_named_file in = {"the mesh", q->mesh};
    const ss_named_file out[] = {{"--out", q->out}, {"--preview", q->preview}};
    (void)ss_files_check(&in, 1, out, 2, error);
    if (q->mesh != NULL && !organ_is_text(q->mesh)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "'%.100s': a scene cannot name a file whose name is no UTF-8, or has "
                          "control characters: give it another",
                          q->mesh);
    }
    if (q->out != NULL && ss_files_is_in_place(q->out)) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--out: '%.100s' is no file that a server could read; give ORGAN.yaml",
                          q->out);
    }
    return error->fault_count > 0 ? SS_ARGS_BAD : SS_ARGS_RUN;
}

/* ---- choices before the scene is loaded ---- */

/* Are there nodes of more triangles than the contact surface takes? */
static bool has_fans(const ss_mesh *mesh)
{
    int32_t *count = ss_memory_get((size_t)mesh->node_count, sizeof *count);
    bool is_over = false;
    for (int32_t i = 0; count != NULL && i < 3 * mesh->triangle_count; ++i) {
        is_over = ++count[mesh->triangle[i / 3][i % 3]] > SS_MAX_VALENCE || is_over;
    }
    ss_memory_free(count);
    return is_over;
}

/* Cavities are of the body around them. */
static int32_t count_bodies(const ss_mesh *mesh, int32_t component_count)
{
    int32_t *body = ss_memory_get((size_t)mesh->node_count, sizeof *body);
    const int32_t count =
        body != NULL && mesh->is_closed ? ss_mesh_find_bodies(mesh, body) : component_count;
    ss_memory_free(body);
    return count > 0 ? count : component_count;
}

static softsim_status measure(const ss_mesh *mesh, organ *o)
{
    ss_mesh_report report;
    const softsim_status status = ss_mesh_check(mesh, &report);
    if (status != SOFTSIM_OK) {
        return status;
    }
    ss_copy3(o->low, report.box_min);
    ss_copy3(o->high, report.box_max);
    o->volume = fabs(report.volume);
    o->area = report.area;
    o->open_edges = report.open_edge.count;
    o->part_count = count_bodies(mesh, report.component_count);
    ss_mesh_fault crossing;
    ss_progress_stage("looking for triangles that cross others, of %d", mesh->triangle_count);
    o->crossing_count =
        ss_mesh_find_crossings(mesh, &crossing, &o->is_crossing_complete) ? crossing.count : 0;
    o->diagonal = ss_mesh_diagonal(mesh);
    o->edge = ss_mesh_mean_side((const double(*)[3])mesh->position,
                                (const int32_t(*)[3])mesh->triangle, mesh->triangle_count);
    o->is_closed = mesh->is_closed;
    o->has_volume = mesh->tetrahedron_count > 0;
    o->is_second_order = mesh->middle != NULL;
    o->is_fanned = has_fans(mesh);
    return SOFTSIM_OK;
}

static void choose_tool(const organ_request *q, organ *o)
{
    o->usual_radius = fmin(TOOL_SHARE * o->diagonal, FINGERTIP_M);
    o->radius = q->tool_mm > 0.0
                    ? 1e-3 * q->tool_mm
                    : organ_round(fmin(fmax(o->usual_radius, ORGAN_RADIUS_PER_EDGE * o->edge),
                                       LARGEST_TOOL * o->diagonal));
    const double most = DEEPEST_SHARE * organ_height(o);
    o->hand_scale = HAND_DEPTH_M > most ? organ_round(most / HAND_DEPTH_M) : 1.0;
    o->deepest = o->hand_scale * HAND_DEPTH_M;
    o->depth = fmin(0.5 * o->radius, 0.6 * o->deepest);
    const double force =
        trial_hertz(o->tissue->youngs_modulus, tissue_poisson_ratio, o->radius, o->deepest);
    o->working_force = organ_round(fmin(fmax(force, 0.05), 4.0));
    o->planned_max_force = organ_round(fmin(fmax(2.5 * force, 0.5), 8.0));
}

/* Is it a soup, whose triangles are apart? A repair then stitches parts. */
static bool is_joined(const ss_mesh *mesh, const ss_mesh *mended)
{
    ss_mesh_report before, after;
    return ss_mesh_check(mesh, &before) == SOFTSIM_OK &&
           ss_mesh_check(mended, &after) == SOFTSIM_OK &&
           after.component_count < before.component_count &&
           after.open_edge.count < before.open_edge.count;
}

/* Loads the mesh as the scene will have it; mended where it has to be. */
static softsim_status load(const organ_request *q, organ *o, ss_mesh **out, softsim_error *error)
{
    softsim_status status = ss_mesh_load(q->mesh, 1.0, NULL, out, error);
    softsim_error refused = {0};
    if (status != SOFTSIM_OK) {
        return status;
    }
    const bool is_taken = ss_mesh_accept_shape(*out, q->mesh, &refused) == SOFTSIM_OK;
    if (is_taken && ((*out)->is_closed || (*out)->tetrahedron_count > 0)) {
        return status;
    }
    ss_mesh *mended = NULL;
    ss_mesh_repairs done;
    softsim_error still = {0};
    ss_progress_stage("trying to mend %s", q->mesh);
    if (ss_mesh_repair(*out, &mended, &done, &still) == SOFTSIM_OK &&
        ss_mesh_accept_shape(mended, q->mesh, &still) == SOFTSIM_OK &&
        (!is_taken || is_joined(*out, mended))) {
        ss_mesh_destroy(out);
        *out = mended;
        o->is_repaired = true;
        return SOFTSIM_OK;
    }
    if (is_taken) {
        ss_mesh_destroy(&mended);
        return SOFTSIM_OK;
    }
    ss_mesh_destroy(&mended);
    softsim_error_append(error, refused.status, refused.text);
    return refused.status;
}

/* How the scene, in its folder, names the mesh. */
static softsim_status name_mesh(const organ_request *q, char *out, size_t size,
                                softsim_error *error)
{
    char mesh[PATH_MAX], folder[PATH_MAX], scene[PATH_MAX];
    (void)snprintf(scene, sizeof scene, "%s", q->out);
    if (realpath(q->mesh, mesh) == NULL || realpath(dirname(scene), folder) == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "--out: the folder of '%.200s': %s", q->out,
                          strerror(errno));
        return SOFTSIM_ERROR_FILE;
    }
    const size_t length = strlen(folder);
    const bool is_beside = strncmp(mesh, folder, length) == 0 && mesh[length] == '/' &&
                           strchr(mesh + length + 1, '/') == NULL;
    (void)snprintf(out, size, "%s", is_beside ? mesh + length + 1 : mesh);
    return SOFTSIM_OK;
}

/* ---- the scene, loaded and pressed ---- */

/* Writes the text anew; what a world is made from lies under its temporary name. */
static softsim_status write_text(ss_output *output, const organ *o, bool is_draft,
                                 softsim_error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    if (stream == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", output->path);
        return SOFTSIM_ERROR_MEMORY;
    }
    organ_write(stream, o, is_draft);
    bool is_written = fclose(stream) == 0 && ftruncate(output->descriptor, 0) == 0 &&
                      lseek(output->descriptor, 0, SEEK_SET) == 0;
    is_written = is_written && fwrite(text, 1, size, output->file) == size;
    is_written = is_written && fflush(output->file) == 0;
    free(text);
    if (!is_written) {
        softsim_error_add(error, SOFTSIM_ERROR_FILE, "%s: cannot be written: %s", output->path,
                          strerror(errno));
        return SOFTSIM_ERROR_FILE;
    }
    return SOFTSIM_OK;
}

/* Faults of the draft, by the name that the user gave. */
static void pass_on(const ss_output *output, const softsim_error *fault, softsim_error *error)
{
    char text[SOFTSIM_ERROR_TEXT_SIZE] = "";
    size_t used = 0;
    const size_t length = strlen(output->temporary);
    for (const char *at = fault->text; *at != '\0' && used + 1 < sizeof text;) {
        const bool is_name = strncmp(at, output->temporary, length) == 0;
        used += (size_t)snprintf(text + used, sizeof text - used, is_name ? "%s" : "%.1s",
                                 is_name ? output->path : at);
        at += is_name ? length : 1;
    }
    softsim_error_append(error, fault->status, text);
}

/* Of the tools: the largest force is lowered until they do not sink in. Of anything: told. */
typedef struct doubts {
    const organ_request *q;
    int32_t count, of_tools, of_mesh;
    bool is_told;
} doubts;

static void take_doubt(void *sink, const ss_note *note)
{
    doubts *d = sink;
    ++d->count;
    d->of_tools += strcmp(note->where, "contact.tools") == 0;
    d->of_mesh += strcmp(note->where, "object.mesh") == 0;
    if (d->is_told) {
        ss_plain_print(stderr, "softsim-mesh: warning: %s: %s: %s\n", d->q->out, note->where,
                       note->text);
    }
}

static softsim_world *open_world(ss_output *output, const organ *o, softsim_error *error)
{
    softsim_error fault = {0};
    softsim_config config = softsim_default_config();
    config.has_budget = true;
    if (write_text(output, o, true, error) != SOFTSIM_OK) {
        return NULL;
    }
    softsim_world *world = softsim_create(output->temporary, &config, &fault);
    if (world == NULL) {
        pass_on(output, &fault, error);
        return NULL;
    }
    return world;
}

/* The scene as it is planned now, in a world. */
static softsim_world *open_draft(ss_output *output, organ *o, softsim_error *error)
{
    softsim_world *world = open_world(output, o, error);
    for (doubts d = {.of_tools = 1}; world != NULL && d.of_tools > 0;) {
        d = (doubts){0};
        ss_world_doubt(ss_world_of(world), &(const ss_notes){take_doubt, &d});
        o->is_rounded = d.of_mesh > 0;
        const double lowered = organ_round(LOWERED * o->max_force);
        if (d.of_tools == 0 || lowered < LEAST_LIMIT * o->working_force) {
            break;
        }
        o->max_force = lowered;
        softsim_destroy(&world);
        world = open_world(output, o, error);
    }
    if (world == NULL) {
        return NULL;
    }
    const ss_world *inner = ss_world_of(world);
    ss_model_info info;
    inner->model_class->info(inner->model, &info);
    o->node_count = inner->scene->mesh->node_count;
    o->tetrahedron_count = inner->scene->mesh->tetrahedron_count;
    o->stable_step_s = info.stable_step;
    o->step_s = inner->step_period;
    o->step_cost_us = inner->step_cost_us;
    o->fixed_count = 0;
    for (int32_t i = 0; i < o->node_count; ++i) {
        o->fixed_count += inner->scene->fixed[i] != 0;
    }
    return world;
}

static ss_touch_body body_of(softsim_world *world)
{
    const ss_scene *scene = ss_world_of(world)->scene;
    return (ss_touch_body){scene->mesh->node_count, scene->mesh->triangle_count,
                           (const double(*)[3])scene->mesh->position,
                           (const int32_t(*)[3])scene->mesh->triangle, scene->fixed};
}

static softsim_status find_place(const organ_request *q, softsim_world *world, organ *o,
                                 softsim_error *error)
{
    const ss_touch_body body = body_of(world);
    const ss_touch_end end = {o->radius, 0.0, true};
    if (ss_touch_find(&body, o->towards, &end, &o->touch)) {
        ss_madd3(o->touch.origin, o->touch.origin, -o->touch_gap, o->towards);
        return SOFTSIM_OK;
    }
    softsim_error_add(
        error, SOFTSIM_ERROR_ARGUMENT,
        "%s: from %s the hand finds nothing to press that is free and level; come from "
        "another side with --from, or hold less with --fixed%s",
        q->mesh, o->side,
        o->is_closed ? "" : "; a sheet is felt from the side that its triangles face");
    return SOFTSIM_ERROR_ARGUMENT;
}

/* Presses to `deepest`. True: the tool touched late, where corners are cut off, and the place is
 * lower now: press once more, in a world of its own. */
static bool press(softsim_world *world, organ *o, double deepest)
{
    trial_press p = {.depth = o->depth, .deepest = deepest, .limit = o->max_force};
    p.expected = trial_hertz(o->tissue->youngs_modulus, tissue_poisson_ratio, o->radius, o->depth);
    ss_copy3(p.origin, o->touch.origin);
    ss_copy3(p.towards, o->towards);
    trial_run(world, &p, &o->trial);
    const bool is_late = o->trial.has_touched && o->trial.late > LATE * o->depth;
    if (is_late) {
        o->touch_gap += o->trial.late;
    }
    return is_late;
}

/* Scales the forces of a model without physical constants to Hertz'. */
static softsim_status scale_forces(const organ_request *q, ss_output *output, organ *o,
                                   softsim_error *error)
{
    softsim_status status = SOFTSIM_OK;
    o->scale = 1.0;
    if (o->model->hints == NULL || o->model->hints->write_organ == NULL) {
        return status;
    }
    for (int k = 0; k < SCALINGS && status == SOFTSIM_OK; ++k) {
        softsim_world *world = open_draft(output, o, error);
        status = world != NULL ? find_place(q, world, o, error) : SOFTSIM_ERROR_SCENE;
        const bool is_late = status == SOFTSIM_OK && press(world, o, o->depth);
        softsim_destroy(&world);
        if (is_late) {
            continue;
        }
        const double ratio = organ_ratio(o);
        if (status != SOFTSIM_OK || !(ratio > 0.0) || fabs(ratio - 1.0) < CLOSE) {
            break;
        }
        o->scale /= fmin(fmax(ratio, 1e-3), 1e3);
    }
    return status;
}

/* Tries one model: *out_is_good when its press is good and in time. One that is planned too slow is
 * pressed where it is the last, since that is kept. */
static softsim_status try_model(const organ_request *q, ss_output *output, organ *o, bool is_last,
                                bool *out_is_good, softsim_error *error)
{
    *out_is_good = false;
    o->touch_gap = 0.0;
    o->max_force = o->planned_max_force;
    ss_progress_stage("pressing %s as %s", q->mesh, o->model->name);
    softsim_status status = scale_forces(q, output, o, error);
    softsim_world *world = status == SOFTSIM_OK ? open_draft(output, o, error) : NULL;
    if (world == NULL) {
        return status != SOFTSIM_OK ? status : SOFTSIM_ERROR_SCENE;
    }
    status = find_place(q, world, o, error);
    const ss_world *inner = ss_world_of(world);
    const bool is_in_time = o->step_cost_us <= PLANNED_SHARE * 1e6 * o->step_s &&
                            inner->step_ticks <= slowest[q->purpose];
    if (status == SOFTSIM_OK && (is_in_time || is_last)) {
        if (press(world, o, o->deepest)) {
            softsim_destroy(&world);
            world = open_draft(output, o, error);
            status = world != NULL ? find_place(q, world, o, error) : SOFTSIM_ERROR_SCENE;
            if (status == SOFTSIM_OK) {
                (void)press(world, o, o->deepest);
            }
        }
        *out_is_good = status == SOFTSIM_OK && is_in_time && o->trial.has_touched &&
                       !organ_is_stiff(o) &&
                       (o->trial.verdict == SOFTSIM_VERDICT_GOOD || o->trial.is_of_place) &&
                       o->trial.step_us < o->trial.period_us;
    }
    softsim_destroy(&world);
    return status;
}

/* ---- the whole ---- */

/* Why another model is tried after this one. */
static void note_passed_over(organ *o, softsim_status status, const softsim_error *error)
{
    const trial_result *t = &o->trial;
    const size_t used = strlen(o->passed_over), room = sizeof o->passed_over - used;
    char *at = o->passed_over + used;
    const char *before = used > 0 ? "; " : "", *name = o->model->name;
    if (status != SOFTSIM_OK) {
        (void)snprintf(at, room, "%s%s (%.60s)", before, name, error->text);
    } else if (t->period_us > 0.0 && t->verdict != SOFTSIM_VERDICT_GOOD) {
        (void)snprintf(at, room, "%s%s (%s)", before, name, softsim_verdict_name(t->verdict));
    } else if (t->period_us > 0.0 && organ_is_stiff(o)) {
        (void)snprintf(at, room, "%s%s (%.2f times Hertz's force)", before, name, organ_ratio(o));
    } else if (t->period_us > 0.0) {
        (void)snprintf(at, room, "%s%s (a step of %.3g ms took %.3g ms here)", before, name,
                       1e3 * o->step_s, 1e-3 * t->step_us);
    } else {
        (void)snprintf(at, room, "%s%s (a step of %.3g ms is planned with %.3g ms)", before, name,
                       1e3 * o->step_s, 1e-3 * o->step_cost_us);
    }
}

/* The first of those from `at` on that may do; `count` when none does. */
static int next_model(const organ *o, const char *const name[], int at, int count)
{
    for (; at < count; ++at) {
        const ss_model_class *model = name[at] != NULL ? ss_model_find(name[at]) : NULL;
        if (model != NULL && (!model->needs_volume || o->has_volume) &&
            (!o->is_second_order || model->takes_second_order)) {
            break;
        }
    }
    return at;
}

static bool is_pressed_well(const organ *o, softsim_status status)
{
    return status == SOFTSIM_OK && o->trial.has_touched && o->trial.verdict == SOFTSIM_VERDICT_GOOD;
}

/* Goes through the models that may do until one is good; the last is kept otherwise. */
static softsim_status choose_model(const organ_request *q, ss_output *output, organ *o,
                                   softsim_error *error)
{
    /* For speed no model is wanted that takes second-order elements. */
    const char *const *name = q->model != NULL     ? &q->model
                              : o->is_second_order ? wanted[ORGAN_FOR_ACCURACY]
                                                   : wanted[q->purpose];
    const int count = q->model != NULL ? 1 : MAX_MODELS;
    char before[sizeof o->passed_over] = "";
    int stiff = -1; /* one that is good but for its force, which is better than none that is good */
    softsim_status status = SOFTSIM_ERROR_UNSUPPORTED;
    bool is_good = false;
    for (int i = next_model(o, name, 0, count), next; i < count && !is_good; i = next) {
        next = next_model(o, name, i + 1, count);
        if (o->model != NULL) {
            note_passed_over(o, status, error);
        }
        *error = (softsim_error){0};
        o->model = ss_model_find(name[i]);
        o->trial = (trial_result){0};
        status = try_model(q, output, o, next == count, &is_good, error);
        if (status == SOFTSIM_ERROR_ARGUMENT) {
            break; /* no model would do */
        }
        if (is_pressed_well(o, status) && organ_is_stiff(o)) {
            stiff = i;
            memcpy(before, o->passed_over, sizeof before);
        }
    }
    if (stiff >= 0 && !is_pressed_well(o, status)) {
        memcpy(o->passed_over, before, sizeof before);
        note_passed_over(o, status, error);
        *error = (softsim_error){0};
        o->model = ss_model_find(name[stiff]);
        o->trial = (trial_result){0};
        status = try_model(q, output, o, true, &is_good, error);
    }
    if (status == SOFTSIM_ERROR_UNSUPPORTED) {
        softsim_error_add(error, status, "%s: no model that is built in takes it: %s", q->mesh,
                          o->is_second_order
                              ? "of a mesh with mid-edge nodes, --model fem-quadratic, or "
                                "softsim-mesh convert --order 1 IN OUT first"
                              : "--model NAME");
    }
    return status;
}

/* What was written, once more as a server will read it: what is doubtful is told, and it is drawn.
 */
static softsim_status finish(const organ_request *q, ss_output *output, const organ *o,
                             softsim_error *error)
{
    const softsim_config config = softsim_default_config();
    softsim_world *world = softsim_create(output->temporary, &config, error);
    if (world == NULL) {
        return SOFTSIM_ERROR_SCENE;
    }
    doubts d = {.q = q, .is_told = true};
    const ss_touch_body body = body_of(world);
    ss_progress_end();
    ss_world_doubt(ss_world_of(world), &(const ss_notes){take_doubt, &d});
    const softsim_status status =
        q->preview != NULL ? organ_draw(o, &body, q->preview, error) : SOFTSIM_OK;
    softsim_destroy(&world);
    return status == SOFTSIM_OK ? leftover_commit(output, error) : status;
}

static softsim_status make(const organ_request *q, ss_mesh *mesh, ss_output *output, organ *o,
                           softsim_error *error)
{
    char name[PATH_MAX];
    softsim_status status = organ_choose_unit(o, q->mesh, q->units, mesh, error);
    if (status != SOFTSIM_OK || (status = name_mesh(q, name, sizeof name, error)) != SOFTSIM_OK) {
        return status;
    }
    o->mesh_name = name;
    if ((status = measure(mesh, o)) != SOFTSIM_OK) {
        softsim_error_add(error, status, "%s: out of memory", q->mesh);
        return status;
    }
    const bool needs_volume =
        q->model != NULL ? ss_model_find(q->model)->needs_volume : q->purpose == ORGAN_FOR_ACCURACY;
    if (needs_volume && !o->has_volume) {
        return organ_refuse_surface(q, o, error);
    }
    if (2e-3 * q->tool_mm > o->diagonal) {
        softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                          "--tool-mm: a radius of %g mm is wider than the organ of %.3g mm: give a "
                          "smaller one, or other --units",
                          q->tool_mm, 1e3 * o->diagonal);
        return SOFTSIM_ERROR_ARGUMENT;
    }
    if (!(organ_height(o) > 0.0)) {
        softsim_error_add(
            error, SOFTSIM_ERROR_MESH,
            "%s: it is flat, seen from where the hand comes, and has no side away from "
            "it to be held: give another --from; a flat sheet needs a scene by hand "
            "(server/scene/README.md)",
            q->mesh);
        return SOFTSIM_ERROR_MESH;
    }
    choose_tool(q, o);
    status = organ_choose_fixed(q, mesh, o, error);
    status = status == SOFTSIM_OK ? leftover_open(output, q->out, error) : status;
    if (status == SOFTSIM_OK && (status = choose_model(q, output, o, error)) != SOFTSIM_OK) {
        organ_advise(q, o, status, error);
    }
    status = status == SOFTSIM_OK ? write_text(output, o, false, error) : status;
    return status == SOFTSIM_OK ? finish(q, output, o, error) : status;
}

static int write_scene(const void *what, softsim_error *error)
{
    const organ_request *q = what;
    if (q->lists_tissues) {
        tissue_print(stdout);
        return 0;
    }
    ss_mesh *mesh = NULL;
    ss_output output = {0};
    organ o = {.tissue = tissue_find(q->tissue_name),
               .side = ss_touch_sides[q->side].name,
               .axes = ss_touch_sides[q->side].axes,
               .scale = 1.0};
    ss_copy3(o.towards, ss_touch_sides[q->side].towards);
    ss_progress_begin("softsim-mesh", "reading %s", q->mesh);
    softsim_status status = load(q, &o, &mesh, error);
    status = status == SOFTSIM_OK ? make(q, mesh, &output, &o, error) : status;
    ss_progress_end();
    leftover_abandon(&output);
    ss_mesh_destroy(&mesh);
    if (status != SOFTSIM_OK) {
        return 2;
    }
    organ_report(q, &o);
    return 0;
}

int command_scene(int argc, char **argv)
{
    organ_request q;
    return run_command(argc, argv, &q, parse, write_scene);
}
