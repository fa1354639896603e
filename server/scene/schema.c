/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The tables of keys. A new key is one row here (and, when it is not a plain value with a field
 * of ss_scene, its meaning in scene.c).
 */
#include "scene/schema.h"

#include <math.h>
#include <stddef.h>

#define COUNT(array) (int32_t)(sizeof(array) / sizeof *(array))
#define TABLE(array)                                                                               \
    {                                                                                              \
        array, COUNT(array)                                                                        \
    }
/* A row from its kind, name and help, and one of the keys of another table; the other fields, where
 * they are not 0, stand behind. */
#define ROW(of_kind, key, ...)                                                                     \
    {                                                                                              \
        .name = (key), .kind = SS_SCENE_##of_kind, .help = __VA_ARGS__                             \
    }
#define KEYS(key, ...)                                                                             \
    {                                                                                              \
        .name = (key), .kind = SS_SCENE_KEYS, .child = __VA_ARGS__                                 \
    }
/* Of the types that check.c binds: another does not compile. */
#define FIELD(member)                                                                              \
    .field = 1 + (int32_t)offsetof(ss_scene, member) *                                             \
                     _Generic(((ss_scene *)NULL)->member, double : 1, double * : 1, int32_t : 1,   \
                              ss_scene_between : 1, ss_scene_field : 1, ss_scene_sleep : 1)
#define LIVE(key) .live = 1 + (int32_t)(key)

/* Bounds that only stop nonsense: coordinates in m, and times in s. */
#define FAR     1e4
#define FOREVER 1e9

#define UNITS "mm|cm|m|in|um|dm"
const double ss_scene_unit_metres[] = {1e-3, 1e-2, 1, 0.0254, 1e-6, 0.1};

/* ---- regions: sets of nodes ---- */

static const ss_scene_row plane_row[] = {
    ROW(VECTOR, "point_m", "a point of the plane", .unit = "m", SS_FROM(-FAR, FAR),
        .is_required = true),
    ROW(VECTOR, "normal", "its normal, any length; nodes behind the plane are taken",
        SS_FROM(-FAR, FAR), .is_required = true),
};
static const ss_scene_row sphere_region_row[] = {
    ROW(VECTOR, "center_m", "its centre", .unit = "m", SS_FROM(-FAR, FAR), .is_required = true),
    ROW(NUMBER, "radius_m", "nodes within are taken", .unit = "m", SS_ABOVE(0, FAR),
        .is_required = true),
};

/* Which nodes: of the transformed mesh, in metres, borders included. */
#define REGION_ROWS(letter)                                                                        \
    ROW(BOX, "box_m", "nodes in a box given by its lower and upper corner", .unit = "m",           \
        SS_FROM(-FAR, FAR), .one_of = (letter)),                                                   \
        KEYS("sphere", TABLE(sphere_region_row), .one_of = (letter)),                              \
        KEYS("plane", TABLE(plane_row), .one_of = (letter)),                                       \
        ROW(TEXT, "group", "a physical group of the mesh file", .one_of = (letter)),               \
        ROW(NODES, "nodes", "node numbers from 0, or a file with one a line", .one_of = (letter))
#define AXES_ROW ROW(AXES, "axes", "axes held, of the world frame")

static const ss_scene_row where_row[] = {REGION_ROWS('R')};
const ss_scene_table ss_scene_where = TABLE(where_row);

static const ss_scene_row values_row[] = {
    ROW(FILE, "file",
        "CSV with the header node,value and a row for every node; for material of tetrahedra also "
        "element,value",
        .is_required = true),
};
const ss_scene_table ss_scene_values = TABLE(values_row);

static const ss_scene_row directions_row[] = {
    ROW(FILE, "file", "CSV with the header element,x,y,z and a row for every element",
        .is_required = true),
};
const ss_scene_table ss_scene_directions = TABLE(directions_row);

static const ss_scene_row fixed_row[] = {REGION_ROWS('R'), AXES_ROW};

/* ---- object ---- */

static const ss_scene_row transform_row[] = {
    ROW(NUMBER, "scale", "times this, first", SS_ABOVE(0, 1e6), .fallback = 1),
    ROW(VECTOR, "rotate_deg", "about the world's x, then y, then z", .unit = "degrees",
        SS_FROM(-3600, 3600)),
    ROW(VECTOR, "translate_m", "moved by this, last", .unit = "m", SS_FROM(-FAR, FAR)),
};
/* Grids: mesh.h says how their nodes and elements are numbered. */
#define COUNT_ROW(key, least, text)                                                                \
    ROW(INTEGER, key, text, SS_FROM(least, SS_MESH_MAX_GRID), .is_required = true)
#define SIZE_ROW(key, text)                                                                        \
    ROW(NUMBER, key, text, .unit = "m", SS_ABOVE(0, FAR), .is_required = true)
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
    KEYS("cylinder", TABLE(cylinder_grid_row), .one_of = 'G'),
    KEYS("plane", TABLE(plane_grid_row), .one_of = 'G'),
    ROW(FILE, "file",
        "CSV with the header x,y,z: rows times columns nodes in object.units, row by row",
        .one_of = 'G'),
    ROW(INTEGER, "rows", "of the file's nodes; the direction u runs from row to row",
        SS_FROM(2, SS_MESH_MAX_GRID), .is_required = true, .needs = "file"),
    ROW(INTEGER, "columns", "nodes of a row; the direction w", SS_FROM(2, SS_MESH_MAX_GRID),
        .is_required = true, .needs = "file"),
    ROW(CHOICE, "closed", "what runs back to its first: the last row, or the last column",
        .choices = "none|rows|columns", .needs = "file"),
};
static const ss_scene_row object_row[] = {
    ROW(FILE, "mesh", "surface (OBJ STL PLY OFF GLB MSH VTK) or volume (MSH, TetGen, VTK)",
        .one_of = 'M', .example = "organ.msh"),
    KEYS("grid", TABLE(grid_row), .one_of = 'M',
         .example = "{cylinder: {rows: 15, columns: 24, radius_m: 0.02, length_m: 0.1}}"),
    ROW(CHOICE, "units", "of the file of the mesh, or of a grid's nodes", .choices = UNITS,
        .is_required = true, .unless = "grid"),
    ROW(FILE, "outer",
        "surface around the mesh's volume, in the same units and place: what lies between is the "
        "layer of hybrid",
        .needs = "mesh", .example = "wall.msh"),
    ROW(FILE, "surface",
        "finer surface of the same body, in the same units and place, that the mid-edge nodes of "
        "fem-quadratic follow",
        .needs = "mesh", .example = "skin.obj"),
    KEYS("transform", TABLE(transform_row),
         .example = "{scale: 1, rotate_deg: [0, 0, 90], translate_m: [0, 0, 0.05]}"),
    ROW(BOOL, "repair",
        "weld, drop and turn what softsim-mesh convert --repair does; numbers are then the mended "
        "mesh's"),
    ROW(ENTRIES, "fixed", "nodes that do not move, those of all entries together",
        .child = TABLE(fixed_row),
        .example = "- {box_m: [[-1, -1, -1], [1, 1, -0.02]]}\n"
                   "- {plane: {point_m: [0, 0, -0.02], normal: [0, 0, 1]}}  # what lies behind it\n"
                   "- {sphere: {center_m: [0, -0.017, 0], radius_m: 0.015}}\n"
                   "- {group: bottom, axes: z}  # of the mesh file; free along x and y\n"
                   "- {nodes: [0, 1, 2]}"),
};

/* ---- contact ---- */

#define SHAPE_ROW(of_kind, key, text)                                                              \
    ROW(of_kind, key, text, .unit = "mm", SS_ABOVE(0, 1e4), .is_required = true)
#define RADIUS_ROW       SHAPE_ROW(NUMBER, "radius_mm", "its radius")
#define LENGTH_ROW(text) SHAPE_ROW(NUMBER, "length_mm", text)
static const ss_scene_row sphere_row[] = {RADIUS_ROW};
static const ss_scene_row capsule_row[] = {RADIUS_ROW, LENGTH_ROW("of its axis, without the caps")};
static const ss_scene_row cylinder_row[] = {RADIUS_ROW, LENGTH_ROW("along z")};
static const ss_scene_row cone_row[] = {RADIUS_ROW, LENGTH_ROW("along z, the tip at +z")};
static const ss_scene_row box_row[] = {
    SHAPE_ROW(VECTOR, "size_mm", "its whole edges"),
};
static const ss_scene_row convex_row[] = {
    ROW(FILE, "file", "a convex surface mesh", .is_required = true),
    ROW(CHOICE, "units", "of that file; absent: object.units", .choices = UNITS),
};
static const ss_scene_row shape_row[] = {
    KEYS("sphere", TABLE(sphere_row), .one_of = 'S'),
    KEYS("capsule", TABLE(capsule_row), .one_of = 'S'),
    KEYS("box", TABLE(box_row), .one_of = 'S'),
    KEYS("cylinder", TABLE(cylinder_row), .one_of = 'S'),
    KEYS("cone", TABLE(cone_row), .one_of = 'S'),
    KEYS("convex", TABLE(convex_row), .one_of = 'S'),
};
static const ss_scene_row tool_row[] = {
    ROW(INTEGER, "probe", "which probe moves it", SS_FROM(0, SOFTSIM_MAX_PROBES - 1),
        .is_required = true),
    KEYS("shape", TABLE(shape_row), .is_required = true),
};
static const ss_scene_row contact_row[] = {
    ROW(ENTRIES, "tools", "one per probe, at the probe's origin, axis z", .child = TABLE(tool_row),
        .example =
            "- {probe: 0, shape: {sphere: {radius_mm: 5}}}\n"
            "- {probe: 1, shape: {capsule: {radius_mm: 3, length_mm: 20}}}  # or cylinder, cone\n"
            "- {probe: 2, shape: {box: {size_mm: [10, 10, 4]}}}\n"
            "- {probe: 3, shape: {convex: {file: tip.stl, units: mm}}}"),
    ROW(NUMBER, "working_force_n", "contact stiffness is chosen from it", .unit = "N",
        SS_ABOVE(0, 1e3), .fallback = 2, .one_of = 'c', FIELD(working_force_n)),
    ROW(NUMBER, "stiffness_n_per_m3", "contact stiffness, instead of choosing it", .unit = "N/m^3",
        SS_ABOVE(0, 1e15), .one_of = 'c', FIELD(contact_stiffness_n_per_m3)),
    ROW(FIELD, "friction", "Coulomb's coefficient between tool and tissue; 0 leaves friction out",
        SS_FROM(0, 10)),
    ROW(NUMBER, "grasp_max_force_n",
        "a grasp is torn where the tissue's reaction is more; absent: none is", .unit = "N",
        SS_ABOVE(0, 1e3), .fallback = NAN, FIELD(grasp_max_force_n)),
};

/* ---- simulation, haptic, publish ---- */

static const ss_scene_row simulation_row[] = {
    ROW(RATE, "rate_hz",
        "steps a second; auto: from counted work, in real time also from steps timed at start",
        .unit = "Hz", SS_FROM(1, 1e4), FIELD(simulation_rate_hz)),
    ROW(INTEGER, "max_substeps",
        "in real time, of a step of up to 4 ms, of longer ones more; where that is not enough: "
        "slower than real time, and flagged",
        SS_FROM(1, 1e5), .fallback = 64, FIELD(max_substeps)),
    ROW(CHOICE, "sleep",
        "auto: a body that has been at rest for a second is not stepped until something reaches it",
        .choices = "auto|off", .fallback = SS_SCENE_SLEEP_AUTO, FIELD(sleep)),
};
static const ss_scene_row coupling_row[] = {
    ROW(NUMBER, "stiffness_n_per_m", "the stiffest the hand may feel", .unit = "N/m",
        SS_FROM(1, 1e5), .fallback = 800, FIELD(coupling_stiffness_n_per_m),
        LIVE(SS_LIVE_COUPLING_STIFFNESS)),
    ROW(NUMBER, "damping_n_s_per_m", "of the coupling", .unit = "N s/m", SS_FROM(0, 1e3),
        .fallback = 2, FIELD(coupling_damping_n_s_per_m), LIVE(SS_LIVE_COUPLING_DAMPING)),
};
static const ss_scene_row haptic_row[] = {
    ROW(CHOICE, "between_steps", "what predicts the force between simulation results",
        .choices = "hold|linear|local", .fallback = SS_SCENE_LOCAL, FIELD(between_steps),
        LIVE(SS_LIVE_BETWEEN_STEPS)),
    ROW(NUMBER, "rate_hz", "forces a second", .unit = "Hz", SS_FROM(10, 1e4), .fallback = 1000,
        FIELD(haptic_rate_hz)),
    ROW(NUMBER, "max_force_n", "never more than this on the hand", .unit = "N", SS_FROM(0.01, 100),
        .fallback = 8, FIELD(max_force_n), LIVE(SS_LIVE_MAX_FORCE)),
    ROW(NUMBER, "max_slew_n_per_s", "largest rate of change of the force, rising or falling",
        .unit = "N/s", SS_FROM(10, 1e6), .fallback = 2000, FIELD(max_slew_n_per_s),
        LIVE(SS_LIVE_MAX_SLEW)),
    ROW(NUMBER, "max_jump_m", "a pose further than this from the last is refused", .unit = "m",
        SS_ABOVE(0, 10), .fallback = 0.05, FIELD(max_jump_m), LIVE(SS_LIVE_MAX_JUMP)),
    KEYS("coupling", TABLE(coupling_row)),
};
static const ss_scene_row publish_row[] = {
    ROW(NUMBER, "mesh_rate_hz", "mesh messages a second; 0: none, and no publisher", .unit = "Hz",
        SS_FROM(0, 1e3), .fallback = 60, FIELD(mesh_rate_hz), LIVE(SS_LIVE_MESH_RATE)),
    ROW(NUMBER, "max_bytes_per_s", "of mesh messages, topology included", .unit = "B/s",
        SS_FROM(1e4, 1e10), .fallback = 8e6, FIELD(max_bytes_per_s), LIVE(SS_LIVE_MAX_BYTES)),
    ROW(CHOICE, "field", "a scalar of every surface node, for colouring",
        .choices = SS_SCENE_FIELD_CHOICES, FIELD(field), LIVE(SS_LIVE_FIELD)),
};

/* ---- loads and prescribed displacements ---- */

#define TIME_ROW(key, text) ROW(NUMBER, key, text, .unit = "s", SS_FROM(0, FOREVER))
static const ss_scene_row load_row[] = {
    REGION_ROWS('R'),
    ROW(VECTOR, "force_n", "total force, shared equally by the nodes", .unit = "N",
        SS_FROM(-1e6, 1e6), .one_of = 'L'),
    ROW(NUMBER, "pressure_pa",
        "on the triangles whose nodes are all in the region; it follows them", .unit = "Pa",
        SS_FROM(-1e9, 1e9), .one_of = 'L'),
    TIME_ROW("from_s", "begins"),
    TIME_ROW("to_s", "ends; absent: never"),
    TIME_ROW("ramp_s", "from nothing to full in this time"),
};
static const ss_scene_row prescribed_row[] = {
    REGION_ROWS('r'),
    ROW(VECTOR, "displacement_m", "from rest, the same for every node", .unit = "m",
        SS_FROM(-FAR, FAR), .one_of = 'D'),
    ROW(FILE, "displacement_file",
        "CSV with the header node,ux,uy,uz in m; an empty cell leaves that axis free",
        .one_of = 'D'),
    AXES_ROW,
    TIME_ROW("from_s", "begins"),
    TIME_ROW("ramp_s", "from nothing to full in this time"),
};

/* ---- the file ---- */

static const ss_scene_row root_row[] = {
    ROW(INTEGER, "softsim", "version of the scene format", SS_FROM(1, 1), .is_required = true,
        .fallback = 1),
    KEYS("object", TABLE(object_row), .is_required = true),
    {.name = "model", .kind = SS_SCENE_MODEL, .is_required = true},
    KEYS("contact", TABLE(contact_row)),
    KEYS("simulation", TABLE(simulation_row)),
    ROW(VECTOR, "gravity_m_s2", "acceleration on everything", .unit = "m/s^2", SS_FROM(-1e3, 1e3),
        FIELD(gravity)),
    KEYS("haptic", TABLE(haptic_row)),
    KEYS("publish", TABLE(publish_row)),
    ROW(ENTRIES, "loads", "forces without a tool; where: as object.fixed", .child = TABLE(load_row),
        .example = "- {nodes: [80], force_n: [0.1, -0.8, 0.05], from_s: 0, to_s: 10, ramp_s: 0.1}\n"
                   "- {group: endo, pressure_pa: 1000, ramp_s: 0.5}  # follows the surface"),
    ROW(ENTRIES, "prescribed", "displacements without a tool; where: as object.fixed",
        .child = TABLE(prescribed_row),
        .example =
            "- {group: patch, displacement_m: [0, 0, -0.005], from_s: 0, ramp_s: 0.5, axes: xyz}\n"
            "- {box_m: [[0, 0, 0], [1, 1, 1]], displacement_file: u.csv}"),
};
const ss_scene_table ss_scene_root = TABLE(root_row);
