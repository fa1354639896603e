/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* The plan of a world, for --explain: a note per fact, for people or as JSON. */
#include <math.h>
#include <stdio.h>

#include "rt/memory.h"
#include "rt/note.h"
#include "rt/plain.h"
#include "world/world.h"

/* What of the estimated cost of a step is there because of the tools. */
static double contact_cost_us(const ss_world *world)
{
    ss_model_plan plan = ss_world_plan(world);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        plan.tool[p].is_used = false;
    }
    return fmax(world->step_cost_us - world->model_class->step_cost_us(&plan), 0.0);
}

enum { MOST_THREADS = 4 };

/* The threads that the daemon starts for this world. */
static int name_threads(const ss_world *world, const char *out[MOST_THREADS])
{
    int count = 0;
    out[count++] = "net";
    out[count++] = "simulation";
    if (world->used_probes) {
        out[count++] = "haptic";
    }
    if (world->surface) {
        out[count++] = "publish";
    }
    return count;
}

static void explain_mesh(const ss_mesh *mesh, const ss_notes *out)
{
    ss_note_used(out, "mesh", "%d nodes, %d surface triangles, %d tetrahedra%s", mesh->node_count,
                 mesh->triangle_count, mesh->tetrahedron_count,
                 mesh->is_closed ? ", closed" : ", open");
    if (mesh->quad_count > 0) {
        ss_note_used(out, "grid", "%d quads, whose halves are the triangles", mesh->quad_count);
    }
    if (mesh->cut_face_count > 0) {
        ss_note_used(out, "mesh",
                     "%d faces of more than three corners were cut into triangles, since not all "
                     "faces are quads",
                     mesh->cut_face_count);
    }
    ss_note_used(out, "numbers", "%s",
                 mesh->file_node ? "by place in memory, the file's in all that is read or written"
                                 : "the file's, whose neighbours are near in memory");
}

/* Is one of them a convex mesh? */
static bool explain_tools(const ss_scene *scene, const ss_notes *out)
{
    static const char *const shapes[] = {"sphere", "capsule", "box", "cylinder", "cone", "convex"};
    bool has_convex = false;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (scene->tool[p].is_used) {
            const ss_shape *shape = &scene->tool[p].shape;
            ss_note_used(out, "contact.tools", "probe %d: %s, bounding radius %.4g mm", p,
                         shapes[shape->kind], 1e3 * ss_shape_bounding_radius(shape));
            has_convex |= shape->kind == SS_SHAPE_CONVEX;
        }
    }
    return has_convex;
}

/* A ball of a tenth of the body that never comes is a tool, too. */
static void leave_out_contact(const ss_world *world, const ss_notes *out)
{
    char put_back[128];
    (void)snprintf(put_back, sizeof put_back,
                   "contact.tools=[{probe: 0, shape: {sphere: {radius_mm: %.6g}}}]",
                   100.0 * ss_mesh_diagonal(world->scene->mesh));
    ss_note_left_out(
        out, "contact", put_back,
        "no tool: no haptic thread, no contact surface, no influence functions of a network");
}

/* Rates, costs and threads of the loops. */
static void explain_loops(const ss_world *world, const ss_notes *out)
{
    const ss_scene *scene = world->scene;
    ss_note_used(out, "simulation",
                 "every %d haptic period%s, %.6g Hz (%s; estimated %.3g us a step)",
                 world->step_ticks, world->step_ticks == 1 ? "" : "s", 1.0 / world->step_period,
                 scene->simulation_rate_hz > 0.0
                     ? "as given"
                     : "chosen from counted work; in real time by steps timed at start",
                 world->step_cost_us);
    if (world->used_probes) {
        ss_note_used(out, "cost of contact",
                     "%.3g us of that estimate; a tool on a mesh that is fine for its size takes "
                     "more, which step_us of a run shows",
                     contact_cost_us(world));
    }
    ss_note_used(out, "haptic", "%.6g Hz, at most %.4g N, felt stiffness at most %.4g N/m",
                 1.0 / world->period, scene->max_force_n, scene->coupling_stiffness_n_per_m);
    const char *names[MOST_THREADS];
    const int count = name_threads(world, names);
    ss_note_used(out, "threads", "%s%s%s%s%s%s%s", names[0], count > 1 ? ", " : "",
                 count > 1 ? names[1] : "", count > 2 ? ", " : "", count > 2 ? names[2] : "",
                 count > 3 ? ", " : "", count > 3 ? names[3] : "");
    if (world->sleep) {
        ss_note_left_out(out, "steps at rest", "simulation.sleep=off",
                         "a body at rest for a second is not stepped until something reaches it");
    } else {
        ss_note_used(out, "simulation.sleep", "off: a body at rest is stepped, too");
    }
    if (!world->used_probes) {
        leave_out_contact(world, out);
    }
    if (!world->surface) {
        ss_note_left_out(out, "mesh publisher", "publish.mesh_rate_hz=60",
                         "publish.mesh_rate_hz is 0: no snapshots, and no thread");
    } else {
        ss_note_used(out, "publish", "%d nodes, %d triangles, %.4g Hz, at most %.4g bytes/s",
                     world->drawn.node_count, world->drawn.triangle_count, scene->mesh_rate_hz,
                     scene->max_bytes_per_s);
    }
}

void ss_world_explain(const ss_world *world, const ss_notes *out)
{
    const ss_scene *scene = world->scene;
    ss_note_used(out, "scene", "%s", scene->path);
    explain_mesh(scene->mesh, out);
    ss_note_used(out, "model", "%s", world->model_class->name);
    world->model_class->explain(world->model, out);
    const bool has_convex = explain_tools(scene, out);
    explain_loops(world, out);
    if (!has_convex) {
        ss_note_left_out(out, "convex narrow phase", NULL, "no convex-mesh tool");
    }
    if (scene->load_count > 0 || scene->prescribed_count > 0) {
        ss_note_used(out, "loads", "%d, prescribed sets: %d", scene->load_count,
                     scene->prescribed_count);
    }
    ss_note_used(out, "memory", "%lld bytes", (long long)ss_memory_in_use());
}

/* ---- JSON ---- */

/* The notes of one kind, as an array. */
typedef struct json_notes {
    FILE *out;
    ss_note_kind kind;
    int count;
} json_notes;

static void take_json(void *sink, const ss_note *note)
{
    json_notes *to = sink;
    if (note->kind == to->kind) {
        fputs(to->count++ > 0 ? ", {\"where\": " : "{\"where\": ", to->out);
        ss_plain_json(to->out, note->where);
        fputs(", \"text\": ", to->out);
        ss_plain_json(to->out, note->text);
        fputc('}', to->out);
    }
}

static void print_notes(const ss_world *world, FILE *out, const char *name, ss_note_kind kind)
{
    json_notes to = {out, kind, 0};
    const ss_notes notes = {take_json, &to};
    fprintf(out, ", \"%s\": [", name);
    if (kind == SS_NOTE_WARNING) {
        ss_world_doubt(world, &notes);
    } else {
        ss_world_explain(world, &notes);
    }
    fputc(']', out);
}

void ss_world_explain_json(const ss_world *world, FILE *out)
{
    const ss_mesh *mesh = world->scene->mesh;
    const char *names[MOST_THREADS];
    const int count = name_threads(world, names);
    fputs("{\"scene\": ", out);
    ss_plain_json(out, world->scene->path);
    fprintf(out,
            ", \"model\": \"%s\", \"nodes\": %d, \"triangles\": %d, \"quads\": %d, "
            "\"tetrahedra\": %d, \"haptic_rate_hz\": %.9g, \"simulation_rate_hz\": %.9g, "
            "\"step_us\": %.9g, \"contact_us\": %.9g, \"bytes\": %lld, \"threads\": [",
            world->model_class->name, mesh->node_count, mesh->triangle_count, mesh->quad_count,
            mesh->tetrahedron_count, 1.0 / world->period, 1.0 / world->step_period,
            world->step_cost_us, world->used_probes ? contact_cost_us(world) : 0.0,
            (long long)ss_memory_in_use());
    for (int i = 0; i < count; ++i) {
        fprintf(out, "%s\"%s\"", i > 0 ? ", " : "", names[i]);
    }
    fputc(']', out);
    print_notes(world, out, "used", SS_NOTE_USED);
    print_notes(world, out, "left_out", SS_NOTE_LEFT_OUT);
    print_notes(world, out, "warnings", SS_NOTE_WARNING);
    fputs("}\n", out);
}
