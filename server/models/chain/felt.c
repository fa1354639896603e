/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * How stiff the chain feels to a tool that presses along n. With c the force on the cells and k_cc
 * that on the tool for a unit motion of the tool, K the links' tangent, D the contact's rows,
 *
 *   H = K + D + 2 k/R_rest,   k(y) = k_cc - 2 c.y + y.H y  >=  k_cc - c.H^-1 c
 *
 * for any motion y, with equality at H y = c, as common/body_felt.c has it for bodies: errs high.
 * All links are taken as taut: a touch begins among slack ones, and those that are not yet will be.
 * D is no less than the contact's own tangent, and the same for cells that move together. y lives
 * on the cells around the contact, link by link outwards, as many as MOST_CELLS and MOST_LINKS
 * hold, so that it costs the same on every mesh; those beyond stand still. It is kept from step to
 * step and improved by a few conjugate gradients: in every step while the contact is young, then
 * every fourth; a step of many sub-steps pays for more. The viscosity is the drag 2 k C |y|^2 of
 * that motion, at most 10 ms of stiffness.
 *
 * Rejected: y on the touched cells alone, which told a liver of 600 N/m as 2000, so that the
 * coupling yielded to a limit that was not reached, and a slow simulation's law corrected the
 * prediction three times too much; slack links as they are, or the drag of some time with them:
 * either a touch begins too soft, or a slide at 60 Hz is too stiff.
 */
#include <math.h>
#include <string.h>

#include "rt/vec.h"

/* Cells and links that are looked at; calls in which a contact is young, and from one improvement
 * to the next; iterations of one, and of a step of many sub-steps, which has one for each so many
 * of them. */
enum {
    MOST_CELLS = 512,
    MOST_LINKS = 6144,
    YOUNG = 8,
    EVERY = 4,
    ITERATIONS = 4,
    SUBSTEPS = 4,
    MOST_ITERATIONS = 32
};
/* s: viscosity over stiffness at most. */
#define MAX_VISCOUS_TIME 0.01

typedef struct near_link {
    int32_t a, b; /* places; b -1: an end that stands still */
    double n[3];
    double along, across; /* N/m */
} near_link;

struct ss_chain_felt {
    int32_t count, link_count;
    int32_t link_bound; /* of all links of the cells, each once or twice */
    int32_t node[MOST_CELLS];
    near_link link[MOST_LINKS];
    int32_t *place;          /* of a cell, from 1; 0: it stands still */
    double rows[MOST_CELLS]; /* N/m: what resists without links */
    double inverse[MOST_CELLS];
    double y[MOST_CELLS][3], push[MOST_CELLS][3], residual[MOST_CELLS][3], search[MOST_CELLS][3],
        scaled[MOST_CELLS][3], product[MOST_CELLS][3];
    /* of every tool: what its last y was */
    struct {
        int32_t age, count;
        int32_t node[MOST_CELLS];
        double y[MOST_CELLS][3];
    } last[SOFTSIM_MAX_PROBES];
};

softsim_status ss_chain_felt_create(ss_model *model)
{
    ss_chain_felt *felt = ss_arena_get(&model->arena, 1, sizeof *felt);
    model->felt = felt;
    if (felt) {
        felt->place = ss_arena_get(&model->arena, (size_t)model->padded, sizeof *felt->place);
    }
    return ss_arena_status(&model->arena);
}

void ss_chain_felt_reset(ss_model *model)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        model->felt->last[k].age = model->felt->last[k].count = 0;
    }
}

/* ---- the cells around a contact ---- */

static void add_cell(const ss_chain_net *net, ss_chain_felt *felt, int32_t node)
{
    const int32_t links = net->first[node + 1] - net->first[node];
    if (felt->place[node] == 0 && felt->count < MOST_CELLS &&
        felt->link_bound + links <= MOST_LINKS) {
        felt->node[felt->count++] = node;
        felt->place[node] = felt->count;
        felt->link_bound += links;
    }
}

/* The link at `position` from the cell at `place` on; false for one of no length. */
static bool set_link(const ss_model *model, int32_t position, int32_t place, near_link *out)
{
    const ss_chain_felt *felt = model->felt;
    const ss_chain_group *group = &model->net->group[position / SS_CHAIN_LANES];
    const int lane = position % SS_CHAIN_LANES;
    const int32_t other = ss_chain_other(model->net, position, felt->node[place]);
    const ss_real *a = model->u + group->a[lane], *b = model->u + group->b[lane];
    const double d[3] = {(double)(group->x[lane] + (b[0] - a[0])),
                         (double)(group->y[lane] + (b[1] - a[1])),
                         (double)(group->z[lane] + (b[2] - a[2]))};
    const double length = ss_norm3(d);
    const double longest = (double)group->rest[lane] + model->ratio * (double)group->slack[lane];
    if (!(length > 0.0)) {
        return false;
    }
    const double k = 2.0 * model->k * (double)group->half[lane];
    *out = (near_link){.a = place,
                       .b = felt->place[other] - 1,
                       .along = k,
                       .across = fmax(0.0, k * (1.0 - longest / length))};
    ss_scale3(out->n, d, 1.0 / length);
    return true;
}

/* Every link once, from its lower place. */
static void find_links(ss_model *model)
{
    ss_chain_felt *felt = model->felt;
    const ss_chain_net *net = model->net;
    felt->link_count = 0;
    for (int32_t i = 0; i < felt->count; ++i) {
        const int32_t node = felt->node[i];
        for (int32_t p = net->first[node]; p < net->first[node + 1]; ++p) {
            const int32_t other = felt->place[ss_chain_other(net, net->at[p], node)] - 1;
            near_link *link = &felt->link[felt->link_count];
            if ((other < 0 || other > i) && set_link(model, net->at[p], i, link)) {
                ++felt->link_count;
            }
        }
    }
}

/* From the cells that the tool touches on outwards, with what the last y was there. */
static void find_cells(ss_model *model, const ss_tool *tool, int probe)
{
    ss_chain_felt *felt = model->felt;
    const ss_chain_net *net = model->net;
    const int32_t *reach;
    const int32_t reach_count = ss_contact_query_candidate_nodes(tool->query, &reach);
    const int32_t *const list[2] = {reach, tool->grasp.node};
    const int32_t count[2] = {reach_count, tool->grasp.count};
    felt->count = felt->link_bound = 0;
    for (int l = 0; l < 2; ++l) {
        for (int32_t n = 0; n < count[l]; ++n) {
            if (model->diagonal_of[list[l][n]] > 0.0) {
                add_cell(net, felt, list[l][n]);
            }
        }
    }
    for (int32_t i = 0; i < felt->count && felt->count < MOST_CELLS; ++i) {
        const int32_t node = felt->node[i];
        for (int32_t p = net->first[node]; p < net->first[node + 1]; ++p) {
            add_cell(net, felt, ss_chain_other(net, net->at[p], node));
        }
    }
    memset(felt->y, 0, (size_t)felt->count * sizeof *felt->y);
    for (int32_t k = 0; k < felt->last[probe].count; ++k) {
        const int32_t place = felt->place[felt->last[probe].node[k]] - 1;
        if (place >= 0) {
            ss_copy3(felt->y[place], felt->last[probe].y[k]);
        }
    }
}

/* ---- H ---- */

static void hold(const ss_model *model, double x[][3])
{
    const ss_chain_felt *felt = model->felt;
    for (int32_t i = 0; i < felt->count; ++i) {
        const ss_real *is_free = model->free + 4 * (ptrdiff_t)felt->node[i];
        for (int a = 0; a < 3; ++a) {
            x[i][a] = is_free[a] > 0 ? x[i][a] : 0.0;
        }
    }
}

static void set_rows(ss_model *model)
{
    ss_chain_felt *felt = model->felt;
    for (int32_t i = 0; i < felt->count; ++i) {
        const int32_t node = felt->node[i];
        felt->rows[i] = model->diagonal_of[node] + 2.0 * model->k * model->leak;
        felt->inverse[i] = felt->rows[i];
        for (int a = 0; a < 3; ++a) {
            felt->push[i][a] = (double)model->push[4 * (ptrdiff_t)node + a];
        }
    }
    for (int32_t e = 0; e < felt->link_count; ++e) {
        const near_link *link = &felt->link[e];
        const double mean = (link->along + 2.0 * link->across) / 3.0;
        felt->inverse[link->a] += mean;
        if (link->b >= 0) {
            felt->inverse[link->b] += mean;
        }
    }
    for (int32_t i = 0; i < felt->count; ++i) {
        felt->inverse[i] = felt->inverse[i] > 0.0 ? 1.0 / felt->inverse[i] : 0.0;
    }
    hold(model, felt->push);
    hold(model, felt->y);
}

/* out = H x */
static void apply(const ss_model *model, double x[][3], double out[][3])
{
    const ss_chain_felt *felt = model->felt;
    static const double still[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; i < felt->count; ++i) {
        ss_scale3(out[i], x[i], felt->rows[i]);
    }
    for (int32_t e = 0; e < felt->link_count; ++e) {
        const near_link *link = &felt->link[e];
        double d[3], f[3];
        ss_sub3(d, x[link->a], link->b >= 0 ? x[link->b] : still);
        ss_scale3(f, d, link->across);
        ss_madd3(f, f, (link->along - link->across) * ss_dot3(link->n, d), link->n);
        ss_add3(out[link->a], out[link->a], f);
        if (link->b >= 0) {
            ss_sub3(out[link->b], out[link->b], f);
        }
    }
    hold(model, out);
}

static double dot(const ss_chain_felt *felt, double x[][3], double y[][3])
{
    double sum = 0.0;
    for (int32_t i = 0; i < felt->count; ++i) {
        sum += ss_dot3(x[i], y[i]);
    }
    return sum;
}

static void precondition(ss_chain_felt *felt)
{
    for (int32_t i = 0; i < felt->count; ++i) {
        ss_scale3(felt->scaled[i], felt->residual[i], felt->inverse[i]);
    }
}

/* Improves y towards H y = c; sets the residual c - H y. */
static void solve_some(ss_model *model, int iterations)
{
    ss_chain_felt *felt = model->felt;
    apply(model, felt->y, felt->product);
    for (int32_t i = 0; i < felt->count; ++i) {
        ss_sub3(felt->residual[i], felt->push[i], felt->product[i]);
    }
    precondition(felt);
    memcpy(felt->search, felt->scaled, sizeof felt->search);
    double rho = dot(felt, felt->residual, felt->scaled);
    const double enough = 1e-12 * rho;
    for (int k = 0; k < iterations && rho > enough; ++k) {
        apply(model, felt->search, felt->product);
        const double share = rho / dot(felt, felt->search, felt->product);
        for (int32_t i = 0; i < felt->count; ++i) {
            ss_madd3(felt->y[i], felt->y[i], share, felt->search[i]);
            ss_madd3(felt->residual[i], felt->residual[i], -share, felt->product[i]);
        }
        precondition(felt);
        const double next = dot(felt, felt->residual, felt->scaled);
        for (int32_t i = 0; i < felt->count; ++i) {
            ss_madd3(felt->search[i], felt->scaled[i], next / rho, felt->search[i]);
        }
        rho = next;
    }
}

/* ---- felt stiffness ---- */

/* Sum of 2 k C |y|^2. */
static double drag_met(const ss_model *model)
{
    const ss_chain_felt *felt = model->felt;
    double sum = 0.0;
    for (int32_t i = 0; i < felt->count; ++i) {
        sum += 2.0 * model->k / model->conductance[felt->node[i]] * ss_dot3(felt->y[i], felt->y[i]);
    }
    return sum;
}

/* y is kept, and the scratch is left as it was found. */
static void keep(ss_model *model, int probe)
{
    ss_chain_felt *felt = model->felt;
    felt->last[probe].count = felt->count;
    memcpy(felt->last[probe].node, felt->node, (size_t)felt->count * sizeof *felt->node);
    memcpy(felt->last[probe].y, felt->y, (size_t)felt->count * sizeof *felt->y);
    for (int32_t i = 0; i < felt->count; ++i) {
        const int32_t node = felt->node[i];
        felt->place[node] = 0;
        model->diagonal_of[node] = 0.0;
        memset(model->push + 4 * (ptrdiff_t)node, 0, 4 * sizeof *model->push);
    }
}

double ss_chain_feel(ss_model *model, int probe, const double normal[3])
{
    ss_chain_felt *felt = model->felt;
    ss_tool *tool = &model->tools.tool[probe];
    if (!tool->was_touching) {
        felt->last[probe].age = felt->last[probe].count = 0;
    }
    const int32_t age = felt->last[probe].age++;
    const int many = model->substeps / SUBSTEPS;
    if (age >= YOUNG && age % EVERY != 0 && many <= ITERATIONS) {
        return model->tool[probe].viscosity;
    }
    ss_tool_add_tangent_diagonal(tool, model->diagonal_of);
    const double k_cc = ss_tool_push(tool, normal, model->push);
    find_cells(model, tool, probe);
    find_links(model);
    set_rows(model);
    solve_some(model,
               many > ITERATIONS ? (many < MOST_ITERATIONS ? many : MOST_ITERATIONS) : ITERATIONS);
    const double told = k_cc - dot(felt, felt->y, felt->push) - dot(felt, felt->y, felt->residual);
    ss_tool_set_felt(tool, isfinite(told) && told > 0.0 ? told : k_cc, k_cc);
    model->tool[probe].viscosity =
        tool->was_touching ? fmin(drag_met(model), MAX_VISCOUS_TIME * tool->felt) : 0.0;
    keep(model, probe);
    return model->tool[probe].viscosity;
}

void ss_chain_slept(ss_model *model, int64_t steps)
{
    for (int k = 0; k < SOFTSIM_MAX_PROBES && model->felt != NULL; ++k) {
        if (model->tools.tool[k].was_touching) {
            model->felt->last[k].age += (int32_t)(steps % EVERY);
        }
    }
}
