/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Meshes at rest: nodes, triangles, quads and tetrahedra, fixed after load.
 *
 * In: a file (OBJ STL PLY GLB through the helper program softsim-import, which runs assimp in a
 * process of its own with limits on memory and time; Gmsh MSH 1, 2.2 and 4.1 in ASCII, OFF, TetGen,
 * VTK legacy and XML by our own bounded readers, in double, numbering kept, hexahedra and the like
 * split) and the unit of its lengths. Out: SI coordinates, 0-based numbers in file order, no tags.
 * The surface of a volume mesh is extracted and wound counter-clockwise seen from outside. Memory
 * belongs to the mesh.
 * Thread: set-up only, but a finished mesh is read-only and may be read from any thread.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "softsim/types.h"

/* A named set of nodes: a physical group of MSH; "marker=1" and "region=2" of TetGen; of VTK
 * "NAME=VALUE" for each value of an array of integers with at most 64 different ones, and "NAME"
 * for an array "group:NAME" of zeros and ones. */
typedef struct ss_mesh_group {
    char name[64];
    int32_t *node;
    int32_t node_count;
} ss_mesh_group;

/* Kinds of elements in files. */
typedef enum ss_mesh_kind {
    SS_MESH_POINT,
    SS_MESH_LINE,
    SS_MESH_LINE_2, /* _2: of second order, with a node in the middle of each edge */
    SS_MESH_TRIANGLE,
    SS_MESH_QUAD,
    SS_MESH_TETRAHEDRON,
    SS_MESH_TETRAHEDRON_2,
    SS_MESH_HEXAHEDRON,
    SS_MESH_PRISM,
    SS_MESH_PYRAMID,
    SS_MESH_POLYGON, /* of other corners, strips, pixels */
    SS_MESH_TRIANGLE_2,
    SS_MESH_HIGHER_ORDER,
    SS_MESH_OTHER,
    SS_MESH_KIND_COUNT
} ss_mesh_kind;

typedef struct ss_mesh {
    int32_t node_count;
    int32_t triangle_count;    /* of the surface */
    int32_t tetrahedron_count; /* 0 for a surface mesh */
    int32_t quad_count;        /* of a surface of quadrangles, a rectangular grid; else 0 */
    int32_t group_count;
    double (*position)[3];  /* m, world frame, node_count */
    int32_t (*triangle)[3]; /* node numbers, counter-clockwise from outside */
    int32_t (*tetrahedron)[4];
    /* Second order: the mid-edge nodes of each tetrahedron, edges 01 02 03 12 13 23; NULL in
     * a mesh of first order. Its triangles are then the quarters of faces: 4f to 4f + 2 those at
     * the corners of face f, which are their first nodes, 4f + 3 the one between the middles of its
     * sides 01 12 20. */
    int32_t (*middle)[6];
    /* Corners in order, counter-clockwise from outside; sides 0-1 and 2-3 run along the grid's
     * first direction (u), 1-2 and 3-0 along its second (w). Its triangles are then the halves of
     * quad q, 2q and 2q + 1. */
    int32_t (*quad)[4];
    ss_mesh_group *group;
    bool is_closed; /* every edge has two triangles, or more that fall into pairs */
    /* Faces of more than three corners that were cut into triangles as the file was read, because
     * not all of its faces are quads. */
    int32_t cut_face_count;
    /* After ss_mesh_renumber: the file's number of each node, and of each element as
     * ss_mesh_element_count counts them; NULL where every number is the file's. */
    int32_t *file_node, *file_element;
    /* Vertices of an OBJ file that lay on another and were joined with it as the file was read, and
     * that no face has, left out. */
    int32_t joined_node_count, unused_node_count;
    /* Hexahedra, prisms and pyramids of the file, by kind, that were split into tetrahedra: a
     * cell's stand in a row, at its place in the file's order. */
    int64_t split[SS_MESH_KIND_COUNT];
    /* Elements of the file that are no part of the mesh, by kind. Points, lines, and faces beside
     * tetrahedra (TRIANGLE, QUAD, POLYGON, TRIANGLE_2) only name nodes for groups; where others are
     * counted the body has gaps. */
    int64_t skipped[SS_MESH_KIND_COUNT];
} ss_mesh;

/* A force on nodes without a tool: total force shared equally; one contact. */
typedef struct ss_load {
    int32_t *node;
    int32_t node_count;
    double force[3]; /* N */
    double pressure; /* Pa; used when is_pressure */
    bool is_pressure;
    double from, to; /* s; to may be INFINITY */
    double ramp;     /* s, from 0 to full */
} ss_load;

/* Does it push at all? A load of 0 N is none. */
static inline bool ss_load_pushes(const ss_load *load)
{
    const double *f = load->force;
    return load->is_pressure ? load->pressure != 0.0 : f[0] != 0.0 || f[1] != 0.0 || f[2] != 0.0;
}

/* "hexahedra" and so on. */
const char *ss_mesh_kind_name(ss_mesh_kind kind);

/* Reads `path`; `metres_per_unit` scales it. Every fault is added to `error`. `import_program`
 * NULL: the softsim-import that was built or installed with this code. */
softsim_status ss_mesh_load(const char *path, double metres_per_unit, const char *import_program,
                            ss_mesh **out_mesh, softsim_error *error);
/* The other file of a TetGen pair, .node and .ele, which ss_mesh_load reads too. False: `path` is
 * of no pair, or too long. */
bool ss_mesh_name_pair(const char *path, char *out, size_t size);
/* The same from a Gmsh MSH text in memory, which needs no terminating
 * zero; `name` is what errors call it. */
softsim_status ss_mesh_read_msh(const char *text, size_t size, const char *name,
                                double metres_per_unit, ss_mesh **out_mesh, softsim_error *error);
/* From arrays, which are copied (generators, tests). tetrahedron may be NULL; with tetrahedra and
 * no triangles the surface is extracted. Non-finite positions and bad indices are kept, for
 * ss_mesh_check to name; no function here follows them. */
softsim_status ss_mesh_create(int32_t node_count, const double (*position)[3],
                              int32_t triangle_count, const int32_t (*triangle)[3],
                              int32_t tetrahedron_count, const int32_t (*tetrahedron)[4],
                              ss_mesh **out_mesh, softsim_error *error);
/* The same of second order: of each tetrahedron the corners, then the nodes in the middle of
 * its edges, in the order of `middle`. */
softsim_status ss_mesh_create_second_order(int32_t node_count, const double (*position)[3],
                                           int32_t tetrahedron_count,
                                           const int32_t (*tetrahedron)[10], ss_mesh **out_mesh,
                                           softsim_error *error);
/* A surface of quads alone, each wound counter-clockwise seen from outside. The first quad of each
 * connected part keeps its first corner; others are turned so that u and w run on over their common
 * sides (quad.c: also what happens where that cannot be, and where quads are cut). */
softsim_status ss_mesh_create_quads(int32_t node_count, const double (*position)[3],
                                    int32_t quad_count, const int32_t (*quad)[4],
                                    ss_mesh **out_mesh, softsim_error *error);
void ss_mesh_destroy(ss_mesh **mesh);

/* What a file with a value for each element counts: tetrahedra of a volume, else quads, else
 * triangles. */
static inline int32_t ss_mesh_element_count(const ss_mesh *mesh)
{
    return mesh->tetrahedron_count > 0 ? mesh->tetrahedron_count
           : mesh->quad_count > 0      ? mesh->quad_count
                                       : mesh->triangle_count;
}

/* Grids of quads, rows times columns of nodes. Node r columns + c is row r's c-th; u runs along the
 * rows' numbers r, w along c. Element r m + c (m: columns of quads) has the nodes
 * (r, c + 1), (r + 1, c + 1), (r + 1, c), (r, c): outside is where, looking from, columns run to
 * the right and rows up. A closed direction has a last quad back to its first node. */
typedef enum ss_mesh_closed {
    SS_MESH_CLOSED_NONE,
    SS_MESH_CLOSED_ROWS,
    SS_MESH_CLOSED_COLUMNS
} ss_mesh_closed;
enum { SS_MESH_MAX_GRID = 1000000 }; /* nodes */
/* 2 rows and columns at least, 3 of a closed direction, or SOFTSIM_ERROR_ARGUMENT. */
softsim_status ss_mesh_create_grid(int32_t rows, int32_t columns, ss_mesh_closed closed,
                                   const double (*position)[3], ss_mesh **out_mesh,
                                   softsim_error *error);
/* An open tube about z: rows are rings from z = -length/2 to length/2, columns start at +x and
 * turn towards +y. */
softsim_status ss_mesh_create_cylinder(int32_t rows, int32_t columns, double radius, double length,
                                       ss_mesh **out_mesh, softsim_error *error);
/* A rectangle about the origin in z = 0, seen from +z: columns along x, rows along y. */
softsim_status ss_mesh_create_plane(int32_t rows, int32_t columns, double width, double height,
                                    ss_mesh **out_mesh, softsim_error *error);

/* x := R (scale x) + translate, R about the world's x, then y, then z. */
void ss_mesh_transform(ss_mesh *mesh, double scale, const double rotate_deg[3],
                       const double translate_m[3]);

/* What is wrong with a mesh: counts, and the first few numbers of each kind: of nodes, triangles
 * or tetrahedra as the name says (bad_index: triangles, then tetrahedra; quads where the surface
 * is of quads); of an edge or face its lowest node. Edges of quads are their sides, not their
 * diagonals. All tolerances are relative to the mean edge (of the tetrahedra, if there are any):
 * areas 1e-6 and volumes 1e-9 of its square and cube, coincidence 1e-6, short edges 1e-3. */
enum { SS_MESH_FIRST = 5 };
typedef struct ss_mesh_fault {
    int64_t count;
    int32_t first[SS_MESH_FIRST];
} ss_mesh_fault;
static inline void ss_mesh_add_fault(ss_mesh_fault *fault, int32_t number)
{
    if (fault->count < SS_MESH_FIRST) {
        fault->first[fault->count] = number;
    }
    ++fault->count;
}

typedef struct ss_mesh_report {
    ss_mesh_fault non_finite, bad_index, zero_area, duplicate_triangle, loose_node, coincident_node,
        short_edge, non_manifold_edge, open_edge, inconsistent_winding;
    ss_mesh_fault inverted_tetrahedron, flat_tetrahedron;
    ss_mesh_fault overlapping_tetrahedron; /* ss_mesh_mark_overlaps */
    ss_mesh_fault non_manifold_node;       /* the triangles around it form more than one fan */
    /* Of a volume, whose surface touches itself there; no fault: ss_mesh_pair_sides. */
    ss_mesh_fault pinched_edge, pinched_node;
    ss_mesh_fault duplicate_tetrahedron, crowded_face; /* a face of more than two tetrahedra */
    /* Of second order: edges whose tetrahedra have different mid-edge nodes; nodes in the middle of
     * two edges, or at a corner too; tetrahedra of a volume that their mid-edge nodes turn inside
     * out at a Gauss point. */
    ss_mesh_fault parted_side, shared_middle, bent_tetrahedron;
    ss_mesh_fault mixed_direction; /* sides along u of one quad and w of the other; no fault */
    int32_t component_count;       /* connected parts, loose nodes not counted */
    bool is_inside_out;            /* a closed part encloses a negative volume and is no cavity */
    double volume;                 /* enclosed by the surface; means nothing when it is open */
    double area, edge_min, edge_mean, edge_max;
    double angle_min; /* degrees, smallest angle of a triangle, or quad */
    double box_min[3], box_max[3];
} ss_mesh_report;

/* SOFTSIM_OK, whatever is wrong with the mesh, or SOFTSIM_ERROR_MEMORY. */
softsim_status ss_mesh_check(const ss_mesh *mesh, ss_mesh_report *out_report);
/* One kind of fault as people are told of it: "WHAT: count (WHERE first, ...): REMEDY". */
typedef struct ss_mesh_finding {
    const char *key; /* the field of the report, for programs */
    const ss_mesh_fault *fault;
    const char *what, *where, *remedy;
    bool is_harmless; /* a scene takes it as it is; others are refused */
    bool is_minor;    /* costs accuracy at most, or ss_mesh_repair mends it without a loss */
} ss_mesh_finding;
enum { SS_MESH_MAX_FINDINGS = 21 };
/* The kinds that have a count above 0; returns how many. They point into `report`. */
int32_t ss_mesh_list_findings(const ss_mesh *mesh, const ss_mesh_report *report,
                              ss_mesh_finding out[SS_MESH_MAX_FINDINGS]);
/* The count and first numbers as text: "3 (node 1, 5, 7)". */
void ss_mesh_print_fault(const ss_mesh_finding *finding, char *out, size_t size);

/* Bodies outside this are a wrong `units` or `scale`, not tissue: their diagonal, m. */
#define SS_MESH_LEAST_SIZE    1e-7
#define SS_MESH_GREATEST_SIZE 1e5
bool ss_mesh_is_size_usable(double diagonal);

/* The verdict for simulation: adds one line per disqualifying fault (with counts and first
 * numbers) to `error`; SOFTSIM_OK or SOFTSIM_ERROR_MESH. Open surfaces and several components
 * are usable. */
softsim_status ss_mesh_accept(const ss_mesh *mesh, const char *name, softsim_error *error);
/* The same whatever its size, while its unit is not known. */
softsim_status ss_mesh_accept_shape(const ss_mesh *mesh, const char *name, softsim_error *error);
/* Shapes of the elements: of tetrahedra, else of quads, else of triangles. Those with a bad index
 * or no volume or area are left out. */
enum { SS_MESH_ANGLE_BINS = 9 }; /* of 10 degrees each, from 0 */
typedef struct ss_mesh_quality {
    /* Tetrahedra: a dihedral angle below 10 or above 170 degrees, or the longest edge more than 20
     * times the least height. Triangles and quads: an angle below 10 degrees. */
    ss_mesh_fault sliver;
    double dihedral_min, dihedral_max;     /* degrees; of tetrahedra, else 0 */
    int64_t histogram[SS_MESH_ANGLE_BINS]; /* elements by their least dihedral angle, or angle */
} ss_mesh_quality;
void ss_mesh_measure_quality(const ss_mesh *mesh, ss_mesh_quality *out);

/* The side of the triangle with which the surface goes on over each side 3 t + c, from corner c of
 * triangle t to the next; -1 on a boundary. Where a volume touches itself in an edge, the surface
 * goes on along the same piece of the body (pinch.c); triangles around a node that are joined by
 * such pairs are one fan. out_unpaired: a side of an edge whose triangles cannot be paired, since
 * they are not wound in turn; -1: none. False when out of memory. */
bool ss_mesh_pair_sides(const ss_mesh *mesh, int32_t *out_twin, int32_t *out_unpaired);

/* The loops of open edges: count and lowest node of each. False when out of memory. */
bool ss_mesh_find_holes(const ss_mesh *mesh, ss_mesh_fault *out_hole);

/* Of each triangle: has it an edge of its own? False when out of memory. */
bool ss_mesh_mark_open(const ss_mesh *mesh, bool *out_is_open);

/* Triangles of the surface that cross or overlap another; that they touch does not count. Looks at
 * a bounded number of pairs: out_is_complete is false when there were more. False when out of
 * memory. */
bool ss_mesh_find_crossings(const ss_mesh *mesh, ss_mesh_fault *out_triangle,
                            bool *out_is_complete);
/* The same of each triangle. */
bool ss_mesh_mark_crossings(const ss_mesh *mesh, bool *out_is_crossing, bool *out_is_complete);

/* What ss_mesh_repair did: counts, and the first numbers, of the nodes and elements as given. */
typedef struct ss_mesh_repairs {
    ss_mesh_fault bad_element;      /* dropped: of nodes that do not exist or are not finite */
    ss_mesh_fault cut_quad;         /* into triangles, for a surface of quads could not be mended */
    ss_mesh_fault welded_node;      /* onto the lowest node within 1e-6 of the mean edge, at open
                                       edges 1e-3 of it; and the ends of edges shorter than that */
    ss_mesh_fault flat_element;     /* dropped: no area or volume, or a node twice */
    ss_mesh_fault twin_element;     /* dropped: duplicates */
    ss_mesh_fault divided_triangle; /* at a node on its edge */
    ss_mesh_fault flap_triangle;    /* dropped: of walls within a body, and of flaps outside */
    ss_mesh_fault parted_edge;      /* of more than two triangles: into sheets, by angle */
    ss_mesh_fault cut_edge;         /* of one-sided (Moebius) surfaces */
    ss_mesh_fault parted_node;      /* where sheets touched */
    ss_mesh_fault sliver_part;      /* dropped: without a volume, or of nearly no area */
    ss_mesh_fault filled_hole;
    ss_mesh_fault loose_node; /* dropped */
    ss_mesh_fault turned_tetrahedron, turned_triangle;
} ss_mesh_repairs;
/* The kinds that have a count above 0, as they are told; returns how many. They point into
 * `repairs`. is_harmless: numbers of nodes and elements stay. */
int32_t ss_mesh_list_repairs(const ss_mesh_repairs *repairs, bool is_volume,
                             ss_mesh_finding out[SS_MESH_MAX_FINDINGS]);
/* A mended copy (repair.c): what is kept stays in order, what is new comes after it, groups go
 * along. A surface of triangles then has no fault but crossings and holes that are not small. Fails
 * where nothing would be left, and (SOFTSIM_ERROR_MESH) where tetrahedra overlap, which only
 * filling the surface again mends. */
softsim_status ss_mesh_repair(const ss_mesh *mesh, ss_mesh **out_mesh, ss_mesh_repairs *out_repairs,
                              softsim_error *error);
/* Tetrahedra on the same side of a face that they share as their neighbour there, or of a face of
 * more than two. False when out of memory. */
bool ss_mesh_mark_overlaps(const ss_mesh *mesh, double edge_mean, bool *out_is_overlapping);

/* What ss_mesh_remesh did. */
typedef struct ss_mesh_remeshing {
    double distance; /* m: the farthest that a node or triangle's middle of one surface is from the
                        other */
    int32_t rounds, undone_rounds;
    int32_t locked_nodes; /* left as they were, for the surface would have come to cross itself */
    bool is_crossing_complete; /* else not every pair of triangles was looked at */
} ss_mesh_remeshing;
/* A surface of triangles of edges of about `edge`, m (remesh.c), on the one given, which must be
 * one that a scene takes and that does not cross itself. Edges sharper than `feature_deg`, the
 * angle between normals, and borders stay. Nodes in groups go on being in them (of the first 64).
 * Faults are told without a name: SOFTSIM_ERROR_MESH. */
softsim_status ss_mesh_remesh(const ss_mesh *mesh, double edge, double feature_deg,
                              ss_mesh **out_mesh, ss_mesh_remeshing *out, softsim_error *error);

/* A volume with nodes in the straight middle of its edges, which is of second order then: numbered
 * after its own, by the lower node of each edge, then the higher. In a group are those whose edge's
 * ends are, where the edge lies on the surface or in a tetrahedron of the group. */
softsim_status ss_mesh_raise(const ss_mesh *mesh, ss_mesh **out_mesh, softsim_error *error);
/* A volume of second order without its mid-edge nodes; numbers close up. Its nodes
 * must exist, as those of readers do. */
softsim_status ss_mesh_lower(const ss_mesh *mesh, ss_mesh **out_mesh, softsim_error *error);

/* Turns inside-out or inconsistently wound surfaces, so that neighbours agree and closed
 * parts enclose a positive volume (cavities, whose box lies inside another part's, are left as
 * they are). Returns how many triangles were turned, -1 when out of memory. */
int32_t ss_mesh_orient(ss_mesh *mesh);

/* Gives nodes and elements, groups too, the numbers that keep neighbours near in memory
 * (renumber.c); file_node and file_element lead back. Once, on a mesh with good indices and finite
 * positions (ss_mesh_accept); false when out of memory: the mesh is then of no use. */
bool ss_mesh_renumber(ss_mesh *mesh);
static inline int32_t ss_mesh_file_node(const ss_mesh *mesh, int32_t node)
{
    return mesh->file_node != NULL ? mesh->file_node[node] : node;
}
static inline int32_t ss_mesh_file_element(const ss_mesh *mesh, int32_t element)
{
    return mesh->file_element != NULL ? mesh->file_element[element] : element;
}
/* The numbers of points in the order of the Hilbert curve through the cube of edge `size` at their
 * least corner. False when out of memory. */
bool ss_mesh_curve_order(int32_t count, const double (*x)[3], double size, int32_t *out_number);

/* The solid bodies of a closed surface, numbered from 0: parts connected by triangles or
 * tetrahedra, cavities counted to the smallest body around them. out_body has node_count values, -1
 * for loose nodes. Returns their number, -1 when out of memory. */
int32_t ss_mesh_find_bodies(const ss_mesh *mesh, int32_t *out_body);

/* A third of the area of the triangles around each node, m^2: out has node_count values. Quads
 * count as the mean of both ways of cutting them: a rectangle gives each corner a quarter. */
void ss_mesh_node_areas(const ss_mesh *mesh, double *out_area);
/* The same of area vectors. */
void ss_mesh_node_area_vectors(const ss_mesh *mesh, double (*out_vector)[3]);
double ss_mesh_diagonal(const ss_mesh *mesh);
/* The mean of the nodes, and how far the farthest is from it. */
double ss_mesh_radius(const ss_mesh *mesh, double out_middle[3]);
/* The mean direction of the triangles at a node; their number, 0 where they have none. */
int32_t ss_mesh_node_normal(const ss_mesh *mesh, int32_t node, double out_normal[3]);
/* Of triangles; every edge of a closed body counts twice. */
double ss_mesh_mean_side(const double (*position)[3], const int32_t (*triangle)[3], int32_t count);

/* A body of two layers (skin.c): the tetrahedra of `core`, and as its surface `outer` with those
 * faces of the core that it leaves open. Nodes: the core's, then the outer surface's. Closed when
 * both fit together; else refused. Groups are the core's. */
softsim_status ss_mesh_add_skin(const ss_mesh *core, const ss_mesh *outer, ss_mesh **out_mesh,
                                softsim_error *error);
/* The same grown by `thickness` (m): outward from a volume's surface, cavities left, or, negative,
 * inward: the tetrahedra within it are taken out, and no node is. */
softsim_status ss_mesh_grow_skin(const ss_mesh *volume, double thickness, ss_mesh **out_mesh,
                                 softsim_error *error);

/* Writers: OBJ of the surface (quads as such), binary STL of its triangles, MSH 2.2 of everything,
 * legacy VTK (ASCII) of the tetrahedra, else of the surface, with an array of zeros and ones
 * "group:NAME" for each group. What is read back is the same to the last bit; of OBJ and STL
 * without groups and inner nodes, of STL in single precision and with nodes in another order; a
 * mesh beyond that is refused. Written to a temporary file, synced, renamed. */
softsim_status ss_mesh_write_obj(const ss_mesh *mesh, const char *path, softsim_error *error);
softsim_status ss_mesh_write_stl(const ss_mesh *mesh, const char *path, softsim_error *error);
softsim_status ss_mesh_write_msh(const ss_mesh *mesh, const char *path, softsim_error *error);
softsim_status ss_mesh_write_vtk(const ss_mesh *mesh, const char *path, softsim_error *error);
/* Some of its triangles (3 corners) and tetrahedra (4), to be looked at: legacy VTK with a number
 * for each as the array `name`. */
typedef struct ss_mesh_cell {
    const int32_t *node;
    int corners, value;
} ss_mesh_cell;
softsim_status ss_mesh_write_cells(const ss_mesh *mesh, const ss_mesh_cell *cell, int32_t count,
                                   const char *name, const char *path, softsim_error *error);
