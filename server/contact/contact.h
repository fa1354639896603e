/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Tools against tissue: shapes with a signed distance, the tissue's smooth contact surface, what
 * they do to one another, and the local contact model that is handed to the haptic loop.
 *
 * In: a mesh at rest, the displacement of its nodes (ss_real, x y z 0 a node), the motion of a
 * tool over a step. Out: source weights of the touched nodes with their forces (phi, mu), penalty
 * forces on nodes and tool, contact points with normals and depths.
 *
 * Method (Loop 1987 subdivision rows of the rest mesh as contact samples; one potential of node
 * positions and tool pose, without history but for the anchors of friction): a sample x_q = sum_i
 * B_qi P_i carries rest area A_q and is pushed out of the tool by its depth there, A_q kc D+
 * (harder where the tool is about to go through: query.c; D is smooth where -d has ridges:
 * shape.c); a weight sample x_s at the centroid of a quarter of a triangle gives w_i = sum_s A_s
 * b_si phi(d_s), phi = (1 - d/delta)+^2. Rejected: nodes or facets as contact points, whose force
 * ripples as the tool passes from one to the next; libccd on facets, whose depth can be off by a
 * third. Memory: everything is allocated by the create functions; the rest is RT-safe.
 */
#include <stdbool.h>
#include <stdint.h>

#include "mesh/mesh.h"
#include "rt/real.h"
#include "softsim/types.h"

/* Room of a contact set; a query gives at most 4. */
enum { SS_MAX_CONTACTS = 8 };

/* ---- shapes ---- */

typedef enum ss_shape_kind {
    SS_SHAPE_SPHERE,
    SS_SHAPE_CAPSULE,
    SS_SHAPE_BOX,
    SS_SHAPE_CYLINDER,
    SS_SHAPE_CONE,
    SS_SHAPE_CONVEX
} ss_shape_kind;

typedef struct ss_convex ss_convex; /* a convex mesh */

/* Centred on the tool's origin, axis z. */
typedef struct ss_shape {
    ss_shape_kind kind;
    double radius;         /* m: sphere, capsule, cylinder; cone: of its base at z = -half_length */
    double half_length;    /* m: capsule: of its core; cylinder, cone (apex at +half_length) */
    double half_extent[3]; /* m: box */
    ss_convex *convex;     /* owned by the shape: ss_shape_fini */
} ss_shape;

/* From a mesh file's hull: refuses meshes that are not convex within 1e-3 of their size. */
softsim_status ss_shape_init_convex(ss_shape *shape, const ss_mesh *mesh, softsim_error *error);
void ss_shape_fini(ss_shape *shape);
/* At most `most` of a convex mesh's vertices in the tool's frame, evenly taken where it has more;
 * returns how many, 0 of every other shape. Thread: any. */
int32_t ss_shape_hull(const ss_shape *shape, int32_t most, float (*out_vertex)[3]);

/* Signed distance (m, negative inside) of point `x` in the tool's frame; out_normal is its unit
 * gradient, out of the tool. Thread: any; RT-safe. */
double ss_shape_distance(const ss_shape *shape, const double x[3], double out_normal[3]);
/* Radius of the sphere about the origin that holds the shape. */
double ss_shape_bounding_radius(const ss_shape *shape);
/* The smallest radius of curvature where defined (sphere, capsule, cylinder), else 0. */
double ss_shape_curvature_radius(const ss_shape *shape);
/* Length / sqrt 12, at least 5 mm; 0 for a sphere, which can carry no torque. */
double ss_shape_gyration(const ss_shape *shape);

/* Radius of the largest ball inside (of a convex mesh: about the mean of its vertices): what must
 * not be small beside the tissue's mesh. */
double ss_shape_inradius(const ss_shape *shape);

typedef struct ss_tool_pose {
    double position[3];
    double orientation[4];
} ss_tool_pose;

/* The path of a step: position linear, orientation the shorter way round; s from 0 to 1. RT-safe.
 */
void ss_tool_pose_blend(const ss_tool_pose *from, const ss_tool_pose *to, double s,
                        ss_tool_pose *out);
/* No point of the tool moves further than this on that path, m. Sub-steps of at most R/4 keep the
 * penalty from tunnelling; the broad phase covers the whole path whatever its length. RT-safe. */
double ss_tool_motion_bound(const ss_shape *shape, const ss_tool_pose *from,
                            const ss_tool_pose *to);

/* ---- the tissue's contact surface ---- */

typedef struct ss_surface ss_surface; /* immutable after create */

/* One linear sample at the centroid of each triangle, for both penalty and weights: coarse, but
 * with closed forms to check against. */
enum { SS_SURFACE_CENTROIDS = -1 };
/* Triangles around a node, at most; more are refused: rows grow with them. */
enum { SS_MAX_VALENCE = 128 };

/* `parts`: each Loop level-2 sub-triangle is split into parts^2 (1..4); 0 chooses by the smallest
 * tool radius over the mean edge so that at least 60 samples touch at the working depth; or
 * SS_SURFACE_CENTROIDS. `smallest_tool_radius` (m): the least ss_shape_inradius of the tools, 0
 * where there are none; below 0.3 mean edges the tool falls between the samples' supports and
 * the surface is refused. Also refused: surfaces that are not manifold, non-finite positions. */
softsim_status ss_surface_create(const ss_mesh *mesh, double smallest_tool_radius, int parts,
                                 ss_surface **out_surface, softsim_error *error);
void ss_surface_destroy(ss_surface **surface);
int64_t ss_surface_sample_count(const ss_surface *surface);
/* Mean edge of the triangles at rest, m. */
double ss_surface_mean_edge(const ss_surface *surface);
/* How far a node of the mesh stands out of the sampled surface at rest, m, at most: there, at
 * `out_at` (world), a tool goes into the mesh by so much before it is felt. */
double ss_surface_rounding(const ss_surface *surface, double out_at[3]);

/* Refits the bounding hierarchy to the displaced nodes (`u`: 4 ss_real a node); keeps it, and
 * widens the queries, while no node has moved much since the last refit: one pass over the nodes.
 * Where a tool is present, for the displacements that a step begins with, and for those that
 * ss_contact_query_contacts looks at (the same, a step later); by the simulation thread; RT-safe.
 * The hierarchy belongs to the surface but is scratch: one simulation thread per surface. */
void ss_surface_refit(ss_surface *surface, const ss_real *u);

/* ---- one tool touching the surface ---- */

typedef struct ss_contact_query ss_contact_query; /* scratch of one tool */

typedef struct ss_contact_query_options {
    double delta;     /* m, reach of the source weights: max(mean edge, R/2) */
    double stiffness; /* N/m^3, kc */
} ss_contact_query_options;

softsim_status ss_contact_query_create(const ss_surface *surface, const ss_shape *shape,
                                       const ss_contact_query_options *options,
                                       ss_contact_query **out_query);
void ss_contact_query_destroy(ss_contact_query **query);
void ss_contact_query_set_stiffness(ss_contact_query *query, double stiffness_n_per_m3);

/* Finds the triangles that the tool may reach on its way from `from` to `to` (swept; the path of
 * ss_tool_pose_blend). Call once a step after ss_surface_refit, which tells it whether
 * tissue came near that was out of reach; an earlier broad phase that still covers the path is
 * kept. Complete for poses on the path while no node has moved further than delta (for
 * ss_contact_query_weigh: delta/4) since this call. Nothing is found for a pose that is not
 * finite. Returns their number. RT-safe. */
int32_t ss_contact_query_broad_phase(ss_contact_query *query, const ss_real *u,
                                     const ss_tool_pose *from, const ss_tool_pose *to);
/* Will a broad phase on that path keep the earlier one? Then the hierarchy need not be refitted for
 * it. RT-safe. */
bool ss_contact_query_is_covered(const ss_contact_query *query, const ss_real *u,
                                 const ss_tool_pose *from, const ss_tool_pose *to);

/* Source weights at `pose`: touched nodes with w_i > 0 in increasing node order (deterministic).
 * *out_node, *out_weight stay valid until the next weigh; out_total = W. `is_source[i]` false
 * (fixed nodes) gives no weight; NULL: every node is a source. Returns the count. Keeps d_s, n_s
 * for the forces. RT-safe. */
int32_t ss_contact_query_weigh(ss_contact_query *query, const ss_real *u, const uint8_t *is_source,
                               const ss_tool_pose *pose, const int32_t **out_node,
                               const double **out_weight, double *out_total);
/* The forces through the weights: f_s = -A_s phi'(d_s) (sum_i b_si mu_i) n_s, added to `force`
 * (4 ss_real a node; NULL: the tool's share alone is wanted) by b_si and, with opposite sign, to
 * the tool's force and torque about its origin. `mu`: one value per node returned by the last
 * weigh; NULL: 1 of each. RT-safe. */
void ss_contact_query_weight_forces(const ss_contact_query *query, const double *mu, ss_real *force,
                                    double tool_force[3], double tool_torque[3]);

/* Penalty of the samples inside the tool at `pose`: f_q = A_q kc (-d)+ n added to `force` by
 * B_qi (NULL: the tool's share alone is wanted), ten times as stiff beyond 0.3 of the tool's
 * inradius; the opposite added to tool force and torque; returns the energy.
 * Keeps the active samples for the three calls below. RT-safe. */
double ss_contact_query_penalty(ss_contact_query *query, const ss_real *u, const ss_tool_pose *pose,
                                ss_real *force, double tool_force[3], double tool_torque[3]);
/* Change of the penalty forces for node motions du (4 ss_real a node; NULL: none) and a tool
 * translation dx, linearised at the last ss_contact_query_penalty (d f_q = -A kc c~' n n.(B du -
 * dx), c~' <= c' without its steps: query.c): added to dforce (may be NULL) and dtool. RT-safe. */
void ss_contact_query_tangent(const ss_contact_query *query, const ss_real *du, const double dx[3],
                              ss_real *dforce, double dtool[3]);
/* Adds kc sum_q A_q c' B_qi over active samples to diagonal[i] (N/m): the step bound's contact term
 * and the tangent's preconditioner. RT-safe. */
void ss_contact_query_diagonal(const ss_contact_query *query, double *diagonal);
/* The same of the tangent, with c~'. RT-safe. */
void ss_contact_query_tangent_diagonal(const ss_contact_query *query, double *diagonal);
/* The nodes that the samples found can move, increasing: for sparse clearing. RT-safe. */
int32_t ss_contact_query_candidate_nodes(const ss_contact_query *query, const int32_t **out_node);

/* Friction between tool and surface (friction.c), from now on: `coefficient` mu, or by node of the
 * surface's mesh. Once; without it a query has none of it. Thread: set-up only. */
softsim_status ss_contact_query_add_friction(ss_contact_query *query, double coefficient,
                                             const double *by_node);
/* J: what the springs along the surface hold, and what was lost since the anchors were kept. */
typedef struct ss_friction_energy {
    double stored, lost;
} ss_friction_energy;
/* The friction of the samples of the last ss_contact_query_penalty, at its pose, added as that
 * adds its forces; `pressed` is the normal force over the penalty's, 1 where that is all of it; the
 * tangent below has its stiffness from then on. Forces, tool and energy depend on the anchors that
 * were kept last: keep_friction after each place that a step comes to, not after one that it only
 * tries. RT-safe. */
ss_friction_energy ss_contact_query_friction(ss_contact_query *query, const ss_tool_pose *pose,
                                             double pressed, ss_real *force, double tool_force[3],
                                             double tool_torque[3]);
void ss_contact_query_keep_friction(ss_contact_query *query);
/* Nothing is anchored any more: the tool was away, or elsewhere, or holds the tissue. RT-safe. */
void ss_contact_query_forget_friction(ss_contact_query *query);
/* FNV-1a 64 of the anchors. RT-safe. */
uint64_t ss_contact_query_hash_friction(const ss_contact_query *query, uint64_t hash);

/* The point of triangle abc that is closest to p. RT-safe. */
void ss_contact_closest(const double p[3], const double a[3], const double b[3], const double c[3],
                        double out[3]);
/* How far a placed tool reaches into the surface at displacements `u` (NULL: at rest) (m; negative:
 * its distance; -INFINITY: nowhere near a surface), with the nearest surface point and the outward
 * normal there. For tools that appear: a tool that stands deep inside is on no sample's right side.
 * Looks at every triangle. RT-safe. */
double ss_contact_locate(const ss_mesh *mesh, const ss_real *u, const ss_shape *shape,
                         const ss_tool_pose *pose, double out_point[3], double out_normal[3]);

/* The tissue that a tool appears in. */
typedef struct ss_contact_tissue {
    const ss_mesh *mesh;
    const ss_real *u;
    /* A tool has pressed it: it may spring back to where it rests, and is taken to be there too. */
    bool is_deformed;
} ss_contact_tissue;

typedef struct ss_contact_path {
    int32_t looks; /* on the way */
    bool is_out;
    double way[3]; /* m */
} ss_contact_path;

/* A search for the way out, which goes on in the next step where one is not enough; {0} before. */
typedef struct ss_contact_exit {
    bool is_begun;
    ss_tool_pose from; /* where the tool stood when it began, and both ways begin */
    ss_contact_path nearest, back;
} ss_contact_exit;

typedef enum ss_contact_exit_result {
    SS_EXIT_FOUND,
    SS_EXIT_NONE,      /* no place was found */
    SS_EXIT_UNFINISHED /* call again */
} ss_contact_exit_result;

/* Looks at the tissue in a call, each a pass over all its triangles, or two where it is deformed.
 * Ways that are found take 8 at most in organs and blocks. */
enum { SS_EXIT_LOOKS = 9 };

/* By which way does a tool leave the tissue that it stands in deeper than `spare` (m)? Back against
 * `inward` (unit, as it was pressed in; 0: not known), unless that is far longer than the nearest
 * way; then it just touches. out_way, from where it stood when the search began, is 0 for one that
 * stood outside. RT-safe. */
ss_contact_exit_result ss_contact_leave(const ss_contact_tissue *tissue, const ss_shape *shape,
                                        const ss_tool_pose *pose, double spare,
                                        const double inward[3], ss_contact_exit *search,
                                        double out_way[3]);

/* ---- results for the haptic loop ---- */

/* One contact of the local contact model: force and stiffness at one pose, from which the haptic
 * loop computes forces between two results (haptic/local_contact.c). */
typedef struct ss_contact {
    double point[3];        /* c, on the deformed surface */
    double normal[3];       /* out of the tissue, unit */
    double force;           /* f >= 0 on the tool along normal, N, viscous part included */
    double stiffness;       /* k_n, the model's static tangent, N/m */
    double tangential;      /* k_t, N/m */
    double viscosity;       /* B, N s/m */
    double swift;           /* k of a motion within one step, which the touched tissue's inertia
                               resists too, N/m; of models that solve for it, else 0 */
    double gap;             /* m, > 0: near but not touching */
    double friction[3];     /* N, on the tool, along the surface; not in `force` */
    double coefficient;     /* mu, 0: no friction */
    int32_t station;        /* part of the tool that touches, from 0: from result to result, what
                               has the same one goes on */
    double curvature[3][3]; /* S: symmetric world-frame matrix on the tangent plane, 1/m */
} ss_contact;

typedef struct ss_contact_set {
    int32_t count;
    bool is_held; /* the tool holds tissue: it grasps, or has not quite let go yet */
    bool is_torn; /* and lets go by itself, with the button down: it was drawn too hard */
    ss_contact contact[SS_MAX_CONTACTS];
    double force[3];  /* the model's whole reaction on the tool */
    double torque[3]; /* about the tool's origin */
    double point[3];  /* force-weighted middle of all contacts, on the deformed surface: it
                         slides smoothly, as the deepest sample would not */
    double normal[3]; /* of the resultant there */
    double depth;     /* m, deepest penetration of the stepped tool; negative: nearest distance */
    /* m, the way out for a tool whose middle lies inside the closed surface, and which its contact
     * holds off no longer; else 0 */
    double inside_depth;
    /* Of force and torque, what the contacts do not have: models whose samples are not all that
     * pushes the tool. 0 while held. */
    double other_force[3], other_torque[3];
    /* N/m, of the whole set: the contact's own, tissue held still, where a model tells that in
     * place of `swift`, in which the tissue near the tool gives way. 0: not told. */
    double step_stiffness;
    /* Of force and torque, the friction's: the contacts' own, over the same span as the force. */
    double friction[3], friction_torque[3];
} ss_contact_set;

/* The points, normals, depths and forces of the last ss_contact_query_penalty, reduced to at most
 * SS_MAX_CONTACTS: one for a sphere (through its centre), up to four along the axis of other
 * tools; their forces sum to the penalty's. Force and torque of the set are the penalty's too (the
 * model adds its own). When nothing touches, the nearest patch within `near` (m) with its gap, or
 * no contact and depth = -near. Stiffness and viscosity are left 0 for the model to fill.
 * Call after ss_surface_refit to `u`. RT-safe. */
void ss_contact_query_contacts(ss_contact_query *query, const ss_real *u, const ss_tool_pose *pose,
                               double near, ss_contact_set *out_set);

/* Is the tool inside the tissue, without a grasp that has it there? RT-safe. */
static inline bool ss_contact_is_inside(const ss_contact_set *set)
{
    return set->inside_depth > 0.0 && !set->is_held;
}

/* A result of the simulation as the haptic loop receives it: the contact set and what it was
 * computed for. One mailbox per probe, written after each step by the simulation thread. */
typedef struct ss_simulation_result {
    int64_t tick;           /* haptic tick of the proxy target that was stepped to */
    int64_t step;           /* simulation step number, from 1 */
    double period;          /* s, simulation period h */
    int32_t pose_seq;       /* seq of the pose behind it */
    uint32_t restart_count; /* resets and resumes before it; a model that has had more ignores the
                               tool */
    bool is_fault;          /* the model is at fault: ramp to zero */
    /* The target was inside the tissue: `proxy` is where the tool just touches, `outward` (unit)
     * the way there. The tool stays there until a target says that it was entered. */
    bool is_found_inside;
    double outward[3];
    double proxy[3]; /* p_k, the (predicted) proxy position stepped to */
    double orientation[4];
    double velocity[3]; /* v_k = (p_k - p_{k-1}) / h */
    bool has_stored;    /* the model knows what it has stored */
    double stored;      /* J, kinetic and elastic, after that step */
    double load_work;   /* J, of loads, gravity and supports since start */
    ss_contact_set set;
} ss_simulation_result;

/* What the haptic loop wants the simulation to step to. One mailbox per probe. */
typedef struct ss_proxy_target {
    int64_t tick;
    int32_t pose_seq;
    bool is_present; /* the tool is in the world */
    bool is_grasping;
    uint32_t grasp_edges;   /* counts presses and releases of the button */
    uint32_t teleports;     /* grows when the proxy jumps (start, return): do not sweep */
    uint32_t entries;       /* grows when it goes to where a tool that was found inside stands */
    uint32_t restart_count; /* resets and resumes before the proxy was placed: a model restarted
                             * since then ignores the tool */
    uint32_t holders;       /* grows with each new device */
    bool has_stayed;        /* the device was silent, and came back to where it had been */
    double proxy[3];
    double orientation[4];
    double velocity[3];
    double acceleration[3];
    /* As far as the law answers, the tissue presses back with the force limit `room` m (infinite:
     * no tissue is near) against `outward` (unit) of the proxy. */
    double outward[3], room;
    double turn[3]; /* rad/s, of a tool with extent */
} ss_proxy_target;
