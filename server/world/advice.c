/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * What was mended, what a new scene is, and doubts about a scene that is valid. A wrong unit gives
 * a body or a tool a thousand times too large or too small, and everything about it stays
 * well-formed: only the sizes, side by side, tell. The bounds are wide, so that no sensible scene
 * is doubted; none of them refuses anything, since a whale and an embryo are bodies too.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "contact/touch.h"
#include "rt/note.h"
#include "rt/vec.h"
#include "world/plan.h"
#include "world/world.h"

enum { ALL_AXES = 7 };
static const double SMALLEST_BODY_M = 1e-3;
static const double LARGEST_BODY_M = 10.0;
static const double SMALLEST_TOOL_SHARE = 1e-3; /* of the body's diagonal */
static const double LARGEST_TOOL_SHARE = 1.0;

static void doubt_tool(const ss_notes *out, int32_t p, const ss_shape *shape, double diagonal)
{
    static const char *const key[] = {"sphere.radius_mm",   "capsule.radius_mm", "box.size_mm",
                                      "cylinder.radius_mm", "cone.radius_mm",    "convex.units"};
    char where[64];
    (void)snprintf(where, sizeof where, "contact.tools, probe %d, %s", p, key[shape->kind]);
    const double outer = ss_shape_bounding_radius(shape);
    const double inner = ss_shape_inradius(shape);
    if (outer > LARGEST_TOOL_SHARE * diagonal) {
        ss_note_warning(out, where,
                        "the tool (radius %.4g mm) is larger than the body "
                        "(diagonal %.4g mm); are both in the units they are meant in?",
                        1e3 * outer, 1e3 * diagonal);
    } else if (inner < SMALLEST_TOOL_SHARE * diagonal) {
        ss_note_warning(out, where,
                        "the tool (radius %.4g mm) is less than a thousandth of "
                        "the body (diagonal %.4g mm); are both in the units they are meant in?",
                        1e3 * inner, 1e3 * diagonal);
    }
}

static void tell_repairs(const ss_notes *out, const ss_mesh_repairs *done, bool is_volume)
{
    ss_mesh_finding rows[SS_MESH_MAX_FINDINGS];
    const int32_t count = ss_mesh_list_repairs(done, is_volume, rows);
    for (int32_t i = 0; i < count; ++i) {
        char numbers[160];
        ss_mesh_print_fault(&rows[i], numbers, sizeof numbers);
        ss_note_warning(out, "object.repair", "%s: %s%s", rows[i].what, numbers,
                        rows[i].is_harmless
                            ? ""
                            : "; numbers are those of the mended mesh, which softsim-mesh "
                              "convert --repair writes");
    }
}

/* Can a hand come to where the body is? */
static void doubt_place(const ss_notes *out, const ss_mesh *mesh)
{
    double farthest = 0.0;
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        for (int a = 0; a < 3; ++a) {
            farthest = fmax(farthest, fabs(mesh->position[i][a]));
        }
    }
    if (farthest > SOFTSIM_FARTHEST_M) {
        ss_note_warning(out, "object.mesh",
                        "the body is up to %.4g m from the origin, and poses beyond %g m are "
                        "refused, so that it cannot be touched there; move the mesh nearer, or "
                        "are these its file's units?",
                        farthest, SOFTSIM_FARTHEST_M);
    }
}

/* A body that gives way nowhere is a wall: each of its constants is without effect. */
static void doubt_supports(const ss_notes *out, const ss_scene *scene)
{
    const ss_mesh *mesh = scene->mesh;
    for (int32_t t = 0; t < mesh->triangle_count; ++t) {
        for (int corner = 0; corner < 3; ++corner) {
            if ((scene->fixed[mesh->triangle[t][corner]] & ALL_AXES) != ALL_AXES) {
                return;
            }
        }
    }
    ss_note_warning(out, "object.fixed",
                    "every node of the surface is held, so nothing that a tool touches can "
                    "move; are box_m, plane and sphere in metres, and where the body is?");
}

/* A proxy that a jump left behind, or a hand above what velocities are cut at, comes up with the
 * hand in damping over stiffness: until then nothing is felt. */
static void doubt_coupling(const ss_notes *out, const ss_scene *scene)
{
    const double stiffness = scene->coupling_stiffness_n_per_m;
    const double damping = scene->coupling_damping_n_s_per_m;
    if (damping > SS_LONGEST_TRAIL_S * stiffness) {
        ss_note_warning(out, "haptic.coupling.damping_n_s_per_m",
                        "after a jump the tool comes %.2g s late, damping "
                        "over stiffness; give at most %.4g, or a larger stiffness_n_per_m",
                        damping / stiffness, SS_LONGEST_TRAIL_S * stiffness);
    }
}

/* What the model's plan warns of, for those who do not ask it to explain itself. */
static void pass_warning(void *sink, const ss_note *note)
{
    const ss_notes *out = sink;
    if (note->kind == SS_NOTE_WARNING) {
        out->take(out->sink, note);
    }
}

/* Values by region that nothing has. */
static void doubt_regions(const ss_notes *out, const ss_scene *scene)
{
    for (int32_t i = 0; i < scene->doubt_count; ++i) {
        if (scene->doubt[i].is_unused) {
            ss_note_warning(out, scene->doubt[i].where, "%s", scene->doubt[i].text);
        }
    }
}

void ss_world_doubt(const ss_world *world, const ss_notes *out)
{
    const ss_scene *scene = world->scene;
    const double diagonal = ss_mesh_diagonal(scene->mesh);
    tell_repairs(out, &scene->repairs, scene->mesh->tetrahedron_count > 0);
    if (diagonal < SMALLEST_BODY_M || diagonal > LARGEST_BODY_M) {
        ss_note_warning(out, "object.units",
                        "the body's diagonal is %.4g m; are these the mesh file's units?",
                        diagonal);
    }
    doubt_place(out, scene->mesh);
    doubt_supports(out, scene);
    doubt_regions(out, scene);
    doubt_coupling(out, scene);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (scene->tool[p].is_used) {
            doubt_tool(out, p, &scene->tool[p].shape, diagonal);
        }
    }
    const ss_notes warnings = {pass_warning, (void *)(uintptr_t)out};
    world->model_class->explain(world->model, &warnings);
}

/* ---- summary of a new scene ---- */

bool ss_world_find_touch(const ss_world *world, int32_t *out_probe, int *out_side, ss_touch *out)
{
    const ss_scene *scene = world->scene;
    int32_t p = 0;
    while (p < SOFTSIM_MAX_PROBES && !scene->tool[p].is_used) {
        ++p;
    }
    *out_probe = p;
    if (p == SOFTSIM_MAX_PROBES) {
        return false;
    }
    const ss_touch_body body = {scene->mesh->node_count, scene->mesh->triangle_count,
                                (const double(*)[3])scene->mesh->position,
                                (const int32_t(*)[3])scene->mesh->triangle, scene->fixed};
    const ss_touch_end end = ss_touch_end_of(&scene->tool[p].shape);
    for (int s = 0; s < SS_TOUCH_SIDES; ++s) {
        if (ss_touch_find(&body, ss_touch_sides[s].towards, &end, out)) {
            *out_side = s;
            return true;
        }
    }
    return false;
}

/* How a simulated hand gets to the tissue, from the first side that it can come from. */
static void advise_hand(const ss_world *world, const ss_notes *out)
{
    int32_t p = 0;
    int s = 0;
    ss_touch touch;
    if (ss_world_find_touch(world, &p, &s, &touch)) {
        char probe[24] = "";
        if (p > 0) {
            (void)snprintf(probe, sizeof probe, " --probe %d", p);
        }
        ss_note_used(
            out, "tissue", "from %s: softsim-bridge --device sim%s%s%s --offset-m %.4f,%.4f,%.4f",
            ss_touch_sides[s].name, probe, s > 0 ? " --axes " : "",
            s > 0 ? ss_touch_sides[s].axes : "", touch.origin[0], touch.origin[1], touch.origin[2]);
    } else if (p < SOFTSIM_MAX_PROBES) {
        ss_note_used(out, "tissue",
                     "no side has free and level tissue to press; is too much held?");
    }
}

void ss_world_advise(const ss_world *world, const ss_notes *out)
{
    const ss_scene *scene = world->scene;
    const ss_mesh *mesh = scene->mesh;
    double low[3], high[3];
    int32_t fixed = 0;
    ss_bounds3(mesh->node_count, (const double(*)[3])mesh->position, low, high);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        fixed += scene->fixed[i] != 0;
    }
    ss_note_used(out, "box", "%.4g to %.4g, %.4g to %.4g, %.4g to %.4g m: %.3g x %.3g x %.3g mm",
                 low[0], high[0], low[1], high[1], low[2], high[2], 1e3 * (high[0] - low[0]),
                 1e3 * (high[1] - low[1]), 1e3 * (high[2] - low[2]));
    ss_note_used(out, "fixed", "%d of %d nodes", fixed, mesh->node_count);
    for (int32_t i = 0; i < scene->doubt_count; ++i) {
        if (!scene->doubt[i].is_unused) {
            ss_note_used(out, scene->doubt[i].where, "%s", scene->doubt[i].text);
        }
    }
    const double share = world->step_cost_us / (1e6 * world->step_period);
    ss_note_used(out, "cost", "about %.3g ms of a core for a step of %.3g ms, %.0f %%%s",
                 1e-3 * world->step_cost_us, 1e3 * world->step_period, 100.0 * share,
                 share > 0.5 ? ": slower than real time is likely; a coarser mesh, or another model"
                             : "");
    advise_hand(world, out);
}
