/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Friction of one tool on the surface: a spring along the surface at each sample that touches, from
 * the sample to an anchor that rides on the tool, and Coulomb's limit as a return mapping.
 *
 * Sample q, at r_q from the tool's origin, pushed out by A_q kc c(d_q) along n_q (query.c), has its
 * anchor a_q in the tool's frame, where it came to touch. With R the tool's turn,
 *   s  = (1 - n n^T)(r_q - R a_q)                    stretch along the surface
 *   s' = s min(1, mu c(d_q)/|s|)                     Coulomb: kc A_q |s'| <= mu kc A_q c(d_q)
 *   f  = -kc A_q s'                                  on the tissue, its opposite on the tool
 *   a' = a   while |s| is within the limit (it sticks), else R^T (r_q - s')
 * Springs and limits are per area and as stiff as the contact itself: k_t = kc, so that the bound
 * of its rows (ss_contact_query_diagonal) holds for all directions and no step becomes shorter.
 * Over a step the friction takes f'.(motion along the surface), of which the spring keeps the
 * change of kc A s'^2/2 and the rest,
 *   D = kc A s'.(s - s') >= 0,
 * is lost, and so is what the spring of a sample holds that has come off: nothing gives energy,
 * however the normal force changes. What sticks keeps its anchor: a tool that is held does not
 * creep. Only where the sample has come REACH of the tool's inradius along n from the anchor's
 * plane, in a press or as the tool rolls, the anchor follows along n, which s does not see (each
 * time at the price of a second order in the turn of n: done always, a press that shakes by a
 * hundredth loses what it holds within minutes).
 *
 * The energy kept and D together are the potential of f for limits that stay (Huber's function of
 * s, Simo and Hughes 1998, 2.6 for the mapping), which is what implicit models minimise; its
 * majorant has the stiffness kc A min(1, |s'|/|s|)(1 - n n^T): the tangent. A sample that comes to
 * touch has no spring in that press, wherever it is tried, and so no stiffness.
 *
 * What a press finds is only kept when it is accepted: a step that tries several places asks
 * for the forces at each from the same anchors.
 *
 * Rejected: one anchor for the whole touch (a tool that rolls or turns about the normal has none,
 * and where the touch begins and ends the anchor would have to jump); a force against the sliding
 * velocity, regularised (creeps: a tool at rest sinks along the tissue by itself); anchors on
 * the tissue's nodes (they come and go as a tool passes, and the force ripples).
 */
#include <math.h>
#include <string.h>

#include "contact/internal.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/vec.h"

#define REACH 0.02

/* A sample's anchor, in the tool's frame, and what its spring holds. */
typedef struct anchor {
    int32_t sample_index;
    double at[3];  /* m */
    double energy; /* J */
} anchor;

/* The anchors of the samples in touch, by triangles. */
typedef struct anchors {
    anchor *of;      /* in the samples' order */
    ss_group *group; /* of them */
    int32_t group_count;
    double energy; /* J, of all */
} anchors;

struct ss_contact_friction {
    float *coefficient; /* by triangle */
    int32_t *slot;      /* by triangle: 1 + its group in `kept`, 0 none */
    anchors kept, next;
    bool has_next; /* `next` is of the last press and may be accepted */
};

/* ---- create ---- */

static bool allocate_anchors(const ss_contact_query *query, anchors *out)
{
    out->of = ss_memory_get((size_t)query->sample_capacity, sizeof *out->of);
    out->group = ss_memory_get((size_t)query->surface->triangle_count, sizeof *out->group);
    return out->of != NULL && out->group != NULL;
}

softsim_status ss_contact_query_add_friction(ss_contact_query *query, double coefficient,
                                             const double *by_node)
{
    const ss_surface *surface = query->surface;
    const size_t triangles = (size_t)surface->triangle_count;
    ss_contact_friction *friction = ss_memory_get(1, sizeof *friction);
    query->friction = friction;
    query->rub = ss_memory_get((size_t)query->sample_capacity, sizeof *query->rub);
    if (friction == NULL || query->rub == NULL) {
        return SOFTSIM_ERROR_MEMORY;
    }
    friction->coefficient = ss_memory_get(triangles, sizeof *friction->coefficient);
    friction->slot = ss_memory_get(triangles, sizeof *friction->slot);
    if (friction->coefficient == NULL || friction->slot == NULL ||
        !allocate_anchors(query, &friction->kept) || !allocate_anchors(query, &friction->next)) {
        return SOFTSIM_ERROR_MEMORY;
    }
    for (int32_t t = 0; t < surface->triangle_count; ++t) {
        const int32_t *corner = surface->control + surface->control_first[t];
        friction->coefficient[t] =
            (float)(by_node != NULL
                        ? (by_node[corner[0]] + by_node[corner[1]] + by_node[corner[2]]) / 3.0
                        : coefficient);
    }
    return SOFTSIM_OK;
}

void ss_contact_friction_destroy(ss_contact_query *query)
{
    ss_contact_friction *friction = query->friction;
    if (friction != NULL) {
        void *memory[] = {friction->coefficient, friction->slot,    friction->kept.of,
                          friction->kept.group,  friction->next.of, friction->next.group};
        for (size_t i = 0; i < sizeof memory / sizeof memory[0]; ++i) {
            ss_memory_free(memory[i]);
        }
    }
    ss_memory_free(query->rub);
    ss_memory_free(friction);
}

double ss_contact_friction_coefficient(const ss_contact_query *query, int32_t triangle)
{
    return query->friction != NULL ? (double)query->friction->coefficient[triangle] : 0.0;
}

/* ---- press ---- */

/* The anchor that the sample has, from *inout_at on; NULL for one that comes to touch. */
static const anchor *find_anchor(const anchors *kept, const ss_group *group, int32_t sample_index,
                                 int32_t *inout_at)
{
    if (group == NULL) {
        return NULL;
    }
    const int32_t end = group->first + group->count;
    while (*inout_at < end && kept->of[*inout_at].sample_index < sample_index) {
        ++*inout_at;
    }
    const bool is_there = *inout_at < end && kept->of[*inout_at].sample_index == sample_index;
    return is_there ? &kept->of[*inout_at] : NULL;
}

/* One sample: its spring after the return mapping, s', and its anchor after that; returns the loss
 * D (J). */
static double rub(const ss_sample *sample, const anchor *before, const double q[4], double reach,
                  double limit, double stiffness, ss_rub *out, anchor *after)
{
    const double r[3] = {(double)sample->r[0], (double)sample->r[1], (double)sample->r[2]};
    const double n[3] = {(double)sample->n[0], (double)sample->n[1], (double)sample->n[2]};
    double arm[3], s[3] = {0.0, 0.0, 0.0};
    after->sample_index = sample->sample_index;
    if (before != NULL) {
        ss_rotate(arm, q, before->at);
        ss_sub3(s, r, arm);
    }
    const double rise = ss_dot3(n, s);
    ss_madd3(s, s, -rise, n);
    const double length = ss_norm3(s);
    const double share = length > limit ? limit / length : 1.0;
    if (before != NULL && share == 1.0 && fabs(rise) <= reach) {
        ss_copy3(after->at, before->at);
    } else {
        ss_madd3(arm, r, -share, s);
        ss_rotate_back(after->at, q, arm);
    }
    out->hold = before != NULL ? (ss_real)share : 0;
    for (int k = 0; k < 3; ++k) {
        out->s[k] = (ss_real)(share * s[k]);
    }
    after->energy = 0.5 * stiffness * share * share * length * length;
    return stiffness * share * (1.0 - share) * length * length;
}

/* Adds the force `scale` (N/m) times -s of the samples of a group to the nodes and the tool. */
static void add_forces(const ss_contact_query *query, const ss_group *group, ss_real scale,
                       ss_real *force, double tool_force[3], double tool_torque[3])
{
    const ss_grid *grid = &query->surface->grid;
    ss_wide value[SS_GRID_ROW];
    for (int p = 0; p < SS_GRID_ROW; ++p) {
        value[p] = (ss_wide){0};
    }
    for (int32_t i = group->first; i < group->first + group->count; ++i) {
        const ss_sample *sample = &query->sample[i];
        const ss_real *s = query->rub[i].s;
        const uint8_t *p = grid->facet[sample->sample_index / grid->part_count];
        const ss_real *c = grid->part[sample->sample_index % grid->part_count];
        const ss_wide f = {-scale * s[0], -scale * s[1], -scale * s[2], 0};
        value[p[0]] += c[0] * f;
        value[p[1]] += c[1] * f;
        value[p[2]] += c[2] * f;
        const double on_tool[3] = {-(double)f[0], -(double)f[1], -(double)f[2]};
        const double r[3] = {(double)sample->r[0], (double)sample->r[1], (double)sample->r[2]};
        double turn[3];
        ss_cross3(turn, r, on_tool);
        ss_add3(tool_force, tool_force, on_tool);
        ss_add3(tool_torque, tool_torque, turn);
    }
    ss_surface_scatter(query->surface, group->triangle, value, force);
}

ss_friction_energy ss_contact_query_friction(ss_contact_query *query, const ss_tool_pose *pose,
                                             double pressed, ss_real *force, double tool_force[3],
                                             double tool_torque[3])
{
    ss_contact_friction *friction = query->friction;
    anchors *next = &friction->next;
    const double reach = REACH * ss_shape_inradius(&query->shape);
    double met = 0.0; /* J, of the anchors that go on */
    ss_friction_energy energy = {0.0, 0.0};
    next->group_count = query->group_count;
    next->energy = 0.0;
    friction->has_next = true;
    for (int32_t g = 0; g < query->group_count; ++g) {
        const ss_group *group = &query->group[g];
        const int32_t slot = friction->slot[group->triangle];
        const ss_group *old = slot > 0 ? &friction->kept.group[slot - 1] : NULL;
        const ss_real scale = ss_contact_query_scale(query, group->triangle);
        const double coefficient = pressed * (double)friction->coefficient[group->triangle];
        int32_t at = old != NULL ? old->first : 0;
        next->group[g] = *group;
        for (int32_t i = group->first; i < group->first + group->count; ++i) {
            const ss_sample *sample = &query->sample[i];
            const double limit = coefficient * (double)ss_contact_query_push(query, sample);
            const anchor *before = find_anchor(&friction->kept, old, sample->sample_index, &at);
            energy.lost += rub(sample, before, pose->orientation, reach, limit, (double)scale,
                               &query->rub[i], &next->of[i]);
            met += before != NULL ? before->energy : 0.0;
            next->energy += next->of[i].energy;
        }
        add_forces(query, group, scale, force, tool_force, tool_torque);
    }
    energy.lost += fmax(0.0, friction->kept.energy - met);
    energy.stored = next->energy;
    return energy;
}

/* Writes the groups' slots, or clears them. */
static void set_slots(ss_contact_friction *friction, bool is_set)
{
    for (int32_t g = 0; g < friction->kept.group_count; ++g) {
        friction->slot[friction->kept.group[g].triangle] = is_set ? g + 1 : 0;
    }
}

void ss_contact_query_keep_friction(ss_contact_query *query)
{
    ss_contact_friction *friction = query->friction;
    if (friction->has_next) {
        const anchors kept = friction->kept;
        set_slots(friction, false);
        friction->kept = friction->next;
        friction->next = kept;
        friction->has_next = false;
        set_slots(friction, true);
    }
}

void ss_contact_query_forget_friction(ss_contact_query *query)
{
    ss_contact_friction *friction = query->friction;
    set_slots(friction, false);
    friction->kept.group_count = 0;
    friction->kept.energy = 0.0;
    friction->has_next = false;
    for (int32_t i = 0; i < query->sample_count; ++i) {
        query->rub[i] = (ss_rub){{0}, 0};
    }
}

uint64_t ss_contact_query_hash_friction(const ss_contact_query *query, uint64_t hash)
{
    const anchors *kept = &query->friction->kept;
    for (int32_t g = 0; g < kept->group_count; ++g) {
        const ss_group *group = &kept->group[g];
        hash = ss_hash_bytes(hash, &group->triangle, sizeof group->triangle);
        for (int32_t i = group->first; i < group->first + group->count; ++i) {
            hash = ss_hash_bytes(hash, &kept->of[i].sample_index, sizeof kept->of[i].sample_index);
            hash = ss_hash_bytes(hash, kept->of[i].at, sizeof kept->of[i].at);
        }
    }
    return hash;
}
