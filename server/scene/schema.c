/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The tables of keys. A new key is one row here (and, when it is not a plain value with a field
 * of ss_scene, its meaning in scene.c).
 */
#include "scene/schema.h"

#include <stddef.h>

#define COUNT(array) (int32_t)(sizeof(array) / sizeof *(array))
#define TABLE(array)                                                                               \
    {                                                                                              \
        array, COUNT(array)                                                                        \
    }
/* Of the types that check.c binds: another does not compile. */
#define FIELD(member)                                                                              \
    .field = 1 + (int32_t)offsetof(ss_scene, member) * _Generic(((ss_scene *)NULL)->member,        \
                                                                double : 1, double * : 1,          \
                                                                int32_t : 1, ss_scene_between : 1)
#define LIVE(key) .live = 1 + (int32_t)(key)

/* Bounds that only stop nonsense: coordinates in m, and times in s. */
#define FAR     1e4
#define FOREVER 1e9

#define UNITS "mm|cm|m|in|um|dm"
const double ss_scene_unit_metres[] = {1e-3, 1e-2, 1, 0.0254, 1e-6, 0.1};

/* ---- regions: sets of nodes ---- */

static const ss_scene_row plane_row[] = {
    {.name = "point_m",
     .kind = SS_SCENE_VECTOR,
     .unit = "m",
     .range = {.min = -FAR, .max = FAR},
     .is_required = true,
     .help = "a point of the plane"},
    {.name = "normal",
     .kind = SS_SCENE_VECTOR,
     .range = {.min = -FAR, .max = FAR},
     .is_required = true,
     .help = "its normal, any length; nodes behind the plane are taken"},
};
static const ss_scene_row sphere_region_row[] = {
    {.name = "center_m",
     .kind = SS_SCENE_VECTOR,
     .unit = "m",
     .range = {.min = -FAR, .max = FAR},
     .is_required = true,
     .help = "its centre"},
    {.name = "radius_m",
     .kind = SS_SCENE_NUMBER,
     .unit = "m",
     .range = {.max = FAR, .exclusive_min = true},
     .is_required = true,
     .help = "nodes within are taken"},
};

/* Which nodes: of the transformed mesh, in metres, borders included. */
#define REGION_ROWS(letter)                                                                        \
    {.name = "box_m",                                                                              \
     .kind = SS_SCENE_BOX,                                                                         \
     .unit = "m",                                                                                  \
     .range = {.min = -FAR, .max = FAR},                                                           \
     .one_of = (letter),                                                                           \
     .help = "nodes in a box given by its lower and upper corner"},                                \
        {.name = "sphere",                                                                         \
         .kind = SS_SCENE_KEYS,                                                                    \
         .one_of = (letter),                                                                       \
         .child = TABLE(sphere_region_row)},                                                       \
        {.name = "plane", .kind = SS_SCENE_KEYS, .one_of = (letter), .child = TABLE(plane_row)},   \
        {.name = "group",                                                                          \
         .kind = SS_SCENE_TEXT,                                                                    \
         .one_of = (letter),                                                                       \
         .help = "a physical group of the mesh file"},                                             \
    {                                                                                              \
        .name = "nodes", .kind = SS_SCENE_NODES, .one_of = (letter),                               \
        .help = "node numbers from 0, or a file with one a line"                                   \
    }
#define AXES_ROW                                                                                   \
    {                                                                                              \
        .name = "axes", .kind = SS_SCENE_AXES, .help = "axes held, of the world frame"             \
    }

static const ss_scene_row where_row[] = {REGION_ROWS('R')};
const ss_scene_table ss_scene_where = TABLE(where_row);

static const ss_scene_row values_row[] = {
    {.name = "file",
     .kind = SS_SCENE_FILE,
     .is_required = true,
     .help = "CSV with the header node,value and a row for every node; for "
             "material of tetrahedra also element,value"},
};
const ss_scene_table ss_scene_values = TABLE(values_row);

static const ss_scene_row directions_row[] = {
    {.name = "file",
     .kind = SS_SCENE_FILE,
     .is_required = true,
     .help = "CSV with the header element,x,y,z and a row for every element"},
};
const ss_scene_table ss_scene_directions = TABLE(directions_row);

static const ss_scene_row fixed_row[] = {REGION_ROWS('R'), AXES_ROW};

/* ---- object ---- */

static const ss_scene_row transform_row[] = {
    {.name = "scale",
     .kind = SS_SCENE_NUMBER,
     .range = {.max = 1e6, .exclusive_min = true},
     .fallback = 1,
     .help = "times this, first"},
    {.name = "rotate_deg",
     .kind = SS_SCENE_VECTOR,
     .unit = "degrees",
     .range = {.min = -3600, .max = 3600},
     .help = "about the world's x, then y, then z"},
    {.name = "translate_m",
     .kind = SS_SCENE_VECTOR,
     .unit = "m",
     .range = {.min = -FAR, .max = FAR},
     .help = "moved by this, last"},
};
/* Grids: mesh.h says how their nodes and elements are numbered. */
#define COUNT_ROW(key, least, text)                                                                \
    {                                                                                              \
        .name = (key), .kind = SS_SCENE_INTEGER,                                                   \
        .range = {.min = (least), .max = SS_MESH_MAX_GRID}, .is_required = true, .help = (text)    \
    }
#define SIZE_ROW(key, text)                                                                        \
    {                                                                                              \
        .name = (key), .kind = SS_SCENE_NUMBER, .unit = "m",                                       \
        .range = {.max = FAR, .exclusive_min = true}, .is_required = true, .help = (text)          \
    }
static const ss_scene_row cylinder_grid_row[] = {
    COUNT_ROW("rows", 2, "rings of nodes, from z = -length/2 to length/2; the direction u"),
    COUNT_ROW("columns", 3, "nodes of a ring, from +x towards +y; the direction w"),
    SIZE_ROW("radius_m", "its radius, about z"),
    SIZE_ROW("length_m", "along z, open at both ends"),
};
static const ss_scene_row plane_grid_row[] = {
    COUNT_ROW("rows", 2, "nodes along y; the direction u"),
    COUNT_ROW("columns", 2, "nodes along x; the direction w"),
    SIZE_ROW("width_m", "along x, about the origin"),
    SIZE_ROW("height_m", "along y, about the origin"),
};
static const ss_scene_row grid_row[] = {
    {.name = "cylinder", .kind = SS_SCENE_KEYS, .one_of = 'G', .child = TABLE(cylinder_grid_row)},
    {.name = "plane", .kind = SS_SCENE_KEYS, .one_of = 'G', .child = TABLE(plane_grid_row)},
    {.name = "file",
     .kind = SS_SCENE_FILE,
     .one_of = 'G',
     .help = "CSV with the header x,y,z: rows times columns nodes in object.units, row by row"},
    {.name = "rows",
     .kind = SS_SCENE_INTEGER,
     .range = {.min = 2, .max = SS_MESH_MAX_GRID},
     .is_required = true,
     .needs = "file",
     .help = "of the file's nodes; the direction u runs from row to row"},
    {.name = "columns",
     .kind = SS_SCENE_INTEGER,
     .range = {.min = 2, .max = SS_MESH_MAX_GRID},
     .is_required = true,
     .needs = "file",
     .help = "nodes of a row; the direction w"},
    {.name = "closed",
     .kind = SS_SCENE_CHOICE,
     .choices = "none|rows|columns",
     .needs = "file",
     .help = "what runs back to its first: the last row, or the last column"},
};
static const ss_scene_row object_row[] = {
    {.name = "mesh",
     .kind = SS_SCENE_FILE,
     .one_of = 'M',
     .help = "surface (OBJ STL PLY GLB MSH VTK) or volume (MSH, TetGen, VTK)"},
    {.name = "grid", .kind = SS_SCENE_KEYS, .one_of = 'M', .child = TABLE(grid_row)},
    {.name = "units",
     .kind = SS_SCENE_CHOICE,
     .choices = UNITS,
     .is_required = true,
     .unless = "grid",
     .help = "of the file of the mesh, or of a grid's nodes"},
    {.name = "outer",
     .kind = SS_SCENE_FILE,
     .needs = "mesh",
     .help = "surface around the mesh's volume, in the same units and place: what lies between is "
             "the layer of hybrid"},
    {.name = "transform", .kind = SS_SCENE_KEYS, .child = TABLE(transform_row)},
    {.name = "repair",
     .kind = SS_SCENE_BOOL,
     .help = "weld, drop and turn what softsim-mesh convert --repair does; numbers are then the "
             "mended mesh's"},
    {.name = "fixed",
     .kind = SS_SCENE_ENTRIES,
     .child = TABLE(fixed_row),
     .help = "nodes that do not move"},
};

/* ---- contact ---- */

#define RADIUS_ROW                                                                                 \
    {                                                                                              \
        .name = "radius_mm", .kind = SS_SCENE_NUMBER, .unit = "mm",                                \
        .range = {.max = 1e4, .exclusive_min = true}, .is_required = true, .help = "its radius"    \
    }
#define LENGTH_ROW(text)                                                                           \
    {                                                                                              \
        .name = "length_mm", .kind = SS_SCENE_NUMBER, .unit = "mm",                                \
        .range = {.max = 1e4, .exclusive_min = true}, .is_required = true, .help = (text)          \
    }
static const ss_scene_row sphere_row[] = {RADIUS_ROW};
static const ss_scene_row capsule_row[] = {RADIUS_ROW, LENGTH_ROW("of its axis, without the caps")};
static const ss_scene_row cylinder_row[] = {RADIUS_ROW, LENGTH_ROW("along z")};
static const ss_scene_row cone_row[] = {RADIUS_ROW, LENGTH_ROW("along z, the tip at +z")};
static const ss_scene_row box_row[] = {
    {.name = "size_mm",
     .kind = SS_SCENE_VECTOR,
     .unit = "mm",
     .range = {.max = 1e4, .exclusive_min = true},
     .is_required = true,
     .help = "its whole edges"},
};
static const ss_scene_row convex_row[] = {
    {.name = "file", .kind = SS_SCENE_FILE, .is_required = true, .help = "a convex surface mesh"},
    {.name = "units",
     .kind = SS_SCENE_CHOICE,
     .choices = UNITS,
     .help = "of that file; absent: object.units"},
};
static const ss_scene_row shape_row[] = {
    {.name = "sphere", .kind = SS_SCENE_KEYS, .one_of = 'S', .child = TABLE(sphere_row)},
    {.name = "capsule", .kind = SS_SCENE_KEYS, .one_of = 'S', .child = TABLE(capsule_row)},
    {.name = "box", .kind = SS_SCENE_KEYS, .one_of = 'S', .child = TABLE(box_row)},
    {.name = "cylinder", .kind = SS_SCENE_KEYS, .one_of = 'S', .child = TABLE(cylinder_row)},
    {.name = "cone", .kind = SS_SCENE_KEYS, .one_of = 'S', .child = TABLE(cone_row)},
    {.name = "convex", .kind = SS_SCENE_KEYS, .one_of = 'S', .child = TABLE(convex_row)},
};
static const ss_scene_row tool_row[] = {
    {.name = "probe",
     .kind = SS_SCENE_INTEGER,
     .range = {.max = SOFTSIM_MAX_PROBES - 1},
     .is_required = true,
     .help = "which probe moves it"},
    {.name = "shape", .kind = SS_SCENE_KEYS, .is_required = true, .child = TABLE(shape_row)},
};
static const ss_scene_row contact_row[] = {
    {.name = "tools",
     .kind = SS_SCENE_ENTRIES,
     .child = TABLE(tool_row),
     .help = "one per probe, at the probe's origin, axis z"},
    {.name = "working_force_n",
     .kind = SS_SCENE_NUMBER,
     .unit = "N",
     .range = {.max = 1e3, .exclusive_min = true},
     .fallback = 2,
     .one_of = 'c',
     .help = "contact stiffness is chosen from it",
     FIELD(working_force_n)},
    {.name = "stiffness_n_per_m3",
     .kind = SS_SCENE_NUMBER,
     .unit = "N/m^3",
     .range = {.max = 1e15, .exclusive_min = true},
     .one_of = 'c',
     .help = "contact stiffness, instead of choosing it",
     FIELD(contact_stiffness_n_per_m3)},
};

/* ---- simulation, haptic, publish ---- */

static const ss_scene_row simulation_row[] = {
    {.name = "rate_hz",
     .kind = SS_SCENE_RATE,
     .unit = "Hz",
     .range = {.min = 1, .max = 1e4},
     .help = "steps a second; auto: from counted work",
     FIELD(simulation_rate_hz)},
    {.name = "max_substeps",
     .kind = SS_SCENE_INTEGER,
     .range = {.min = 1, .max = 1e5},
     .fallback = 64,
     .help = "in real time, of a step of up to 4 ms, of longer ones more; where that is not "
             "enough: slower than real time, and flagged",
     FIELD(max_substeps)},
};
static const ss_scene_row coupling_row[] = {
    {.name = "stiffness_n_per_m",
     .kind = SS_SCENE_NUMBER,
     .unit = "N/m",
     .range = {.min = 1, .max = 1e5},
     .fallback = 800,
     .help = "the stiffest the hand may feel",
     FIELD(coupling_stiffness_n_per_m),
     LIVE(SS_LIVE_COUPLING_STIFFNESS)},
    {.name = "damping_n_s_per_m",
     .kind = SS_SCENE_NUMBER,
     .unit = "N s/m",
     .range = {.max = 1e3},
     .fallback = 2,
     .help = "of the coupling",
     FIELD(coupling_damping_n_s_per_m),
     LIVE(SS_LIVE_COUPLING_DAMPING)},
};
static const ss_scene_row haptic_row[] = {
    {.name = "between_steps",
     .kind = SS_SCENE_CHOICE,
     .choices = "hold|linear|local",
     .fallback = SS_SCENE_LOCAL,
     .help = "what predicts the force between simulation results",
     FIELD(between_steps),
     LIVE(SS_LIVE_BETWEEN_STEPS)},
    {.name = "rate_hz",
     .kind = SS_SCENE_NUMBER,
     .unit = "Hz",
     .range = {.min = 10, .max = 1e4},
     .fallback = 1000,
     .help = "forces a second",
     FIELD(haptic_rate_hz)},
    {.name = "max_force_n",
     .kind = SS_SCENE_NUMBER,
     .unit = "N",
     .range = {.min = 0.01, .max = 100},
     .fallback = 8,
     .help = "never more than this on the hand",
     FIELD(max_force_n),
     LIVE(SS_LIVE_MAX_FORCE)},
    {.name = "max_slew_n_per_s",
     .kind = SS_SCENE_NUMBER,
     .unit = "N/s",
     .range = {.min = 10, .max = 1e6},
     .fallback = 2000,
     .help = "largest rate of change of the force, rising or falling",
     FIELD(max_slew_n_per_s),
     LIVE(SS_LIVE_MAX_SLEW)},
    {.name = "max_jump_m",
     .kind = SS_SCENE_NUMBER,
     .unit = "m",
     .range = {.max = 10, .exclusive_min = true},
     .fallback = 0.05,
     .help = "a pose further than this from the last is refused",
     FIELD(max_jump_m),
     LIVE(SS_LIVE_MAX_JUMP)},
    {.name = "coupling", .kind = SS_SCENE_KEYS, .child = TABLE(coupling_row)},
};
static const ss_scene_row publish_row[] = {
    {.name = "mesh_rate_hz",
     .kind = SS_SCENE_NUMBER,
     .unit = "Hz",
     .range = {.max = 1e3},
     .fallback = 60,
     .help = "mesh messages a second; 0: none, and no publisher",
     FIELD(mesh_rate_hz),
     LIVE(SS_LIVE_MESH_RATE)},
    {.name = "max_bytes_per_s",
     .kind = SS_SCENE_NUMBER,
     .unit = "B/s",
     .range = {.min = 1e4, .max = 1e10},
     .fallback = 8e6,
     .help = "of mesh messages, topology included",
     FIELD(max_bytes_per_s),
     LIVE(SS_LIVE_MAX_BYTES)},
};

/* ---- loads and prescribed displacements ---- */

#define TIME_ROW(key, text)                                                                        \
    {                                                                                              \
        .name = (key), .kind = SS_SCENE_NUMBER, .unit = "s", .range = {.max = FOREVER},            \
        .help = (text)                                                                             \
    }
static const ss_scene_row load_row[] = {
    REGION_ROWS('R'),
    {.name = "force_n",
     .kind = SS_SCENE_VECTOR,
     .unit = "N",
     .range = {.min = -1e6, .max = 1e6},
     .one_of = 'L',
     .help = "total force, shared equally by the nodes"},
    {.name = "pressure_pa",
     .kind = SS_SCENE_NUMBER,
     .unit = "Pa",
     .range = {.min = -1e9, .max = 1e9},
     .one_of = 'L',
     .help = "on the triangles whose nodes are all in the region; it follows them"},
    TIME_ROW("from_s", "begins"),
    TIME_ROW("to_s", "ends; absent: never"),
    TIME_ROW("ramp_s", "from nothing to full in this time"),
};
static const ss_scene_row prescribed_row[] = {
    REGION_ROWS('r'),
    {.name = "displacement_m",
     .kind = SS_SCENE_VECTOR,
     .unit = "m",
     .range = {.min = -FAR, .max = FAR},
     .one_of = 'D',
     .help = "from rest, the same for every node"},
    {.name = "displacement_file",
     .kind = SS_SCENE_FILE,
     .one_of = 'D',
     .help = "CSV with the header node,ux,uy,uz in m; an empty cell leaves that axis free"},
    AXES_ROW,
    TIME_ROW("from_s", "begins"),
    TIME_ROW("ramp_s", "from nothing to full in this time"),
};

/* ---- the file ---- */

static const ss_scene_row root_row[] = {
    {.name = "softsim",
     .kind = SS_SCENE_INTEGER,
     .range = {.min = 1, .max = 1},
     .is_required = true,
     .fallback = 1,
     .help = "version of the scene format"},
    {.name = "object", .kind = SS_SCENE_KEYS, .is_required = true, .child = TABLE(object_row)},
    {.name = "model", .kind = SS_SCENE_MODEL, .is_required = true},
    {.name = "contact", .kind = SS_SCENE_KEYS, .child = TABLE(contact_row)},
    {.name = "simulation", .kind = SS_SCENE_KEYS, .child = TABLE(simulation_row)},
    {.name = "gravity_m_s2",
     .kind = SS_SCENE_VECTOR,
     .unit = "m/s^2",
     .range = {.min = -1e3, .max = 1e3},
     .help = "acceleration on everything",
     FIELD(gravity)},
    {.name = "haptic", .kind = SS_SCENE_KEYS, .child = TABLE(haptic_row)},
    {.name = "publish", .kind = SS_SCENE_KEYS, .child = TABLE(publish_row)},
    {.name = "loads",
     .kind = SS_SCENE_ENTRIES,
     .child = TABLE(load_row),
     .help = "forces without a tool"},
    {.name = "prescribed",
     .kind = SS_SCENE_ENTRIES,
     .child = TABLE(prescribed_row),
     .help = "displacements without a tool"},
};
const ss_scene_table ss_scene_root = TABLE(root_row);
