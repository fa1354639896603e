/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/mail.h"
/*
 * chainmail: the traditional 3D ChainMail, beside which cnn-chainmail is judged.
 *
 * After Frisken-Gibson: "3D ChainMail: a fast algorithm for deforming volumetric objects", I3D
 * 1997, for any graph as in Li, Brodlie: "Soft object modelling with generalised ChainMail",
 * Computer Graphics Forum 22 (4), 2003. What a tool or a prescribed set moves is a sponsor; its
 * neighbours are moved by as little as puts them back into the band about it, and sponsor theirs:
 *
 *   box     P_j - P_i clipped, axis by axis, to D +- (alpha |D_q| + beta sum of the other |D|)
 *   radial  |P_j - P_i| clipped to [(1 - alpha) l0, (1 + alpha) l0]
 *
 * D the rest vector. The box is the original; it depends on how the axes lie, the radial band does
 * not. A node moves at most once a step and is tested against its sponsor alone; fixed nodes never
 * move, so links to them may stay out of band. First in, first out, or the largest violation of
 * all first (a binary heap). Optional relaxation moves every free node to the mean displacement of
 * its neighbours, in order, some times a step.
 *
 * Where the nonlinearity comes from: the band's dead zone, and the radial band's geometry. Left
 * out: cutting and tearing. Links are the mesh's edges and stay.
 *
 * There is no force in it: energies and reactions are 0, and so is the model's force on tools;
 * mail_tools.c has what they move and what the hand feels.
 */
#include <math.h>
#include <string.h>

#include "models/common/plan.h"
#include "rt/hash.h"
#include "rt/memory.h"
#include "rt/note.h"
#include "rt/vec.h"

static const ss_param_row rows[SS_MAIL_ROW_COUNT] = {
    [SS_MAIL_ALPHA] =
        SS_PARAM(FIELD, "alpha", "slack of a link along itself, a share of its length",
                 SS_FROM(0.0, 10.0), .fallback = 0.15),
    [SS_MAIL_BETA] = SS_PARAM(NUMBER, "beta", "slack across (shear) of the box band",
                              SS_FROM(0.0, 10.0), .fallback = 0.5),
    [SS_MAIL_BAND] = SS_PARAM(CHOICE, "band", "limits per axis, as Gibson's, or along the link",
                              .range.max = 1.0, .choices = "box|radial"),
    [SS_MAIL_ORDER] =
        SS_PARAM(CHOICE, "order", "who moves next: first come, or the largest violation",
                 .range.max = 1.0, .choices = "fifo|violation"),
    [SS_MAIL_RELAXATION_ITERATIONS] = SS_PARAM(INTEGER, "relaxation_iterations",
                                               "passes of averaging a step", SS_FROM(0.0, 1000.0))};

/* ---- the band ---- */

/* Where the link at `position` wants `node`, given where its sponsor is; returns by how far it
 * is out of its band, m. */
static double place_by(const ss_model *model, int32_t position, int32_t node, int32_t sponsor,
                       double out_u[3])
{
    const ss_chain_group *group = &model->net->group[position / SS_CHAIN_LANES];
    const int lane = position % SS_CHAIN_LANES;
    const double sign = group->b[lane] == 4 * node ? 1.0 : -1.0;
    const double rest[3] = {sign * (double)group->x[lane], sign * (double)group->y[lane],
                            sign * (double)group->z[lane]};
    const ss_real *own = model->u + 4 * (ptrdiff_t)node;
    const ss_real *from = model->u + 4 * (ptrdiff_t)sponsor;
    const double alpha = model->alpha[position];
    double d[3], to[3], way[3];
    for (int k = 0; k < 3; ++k) {
        d[k] = rest[k] + ((double)own[k] - (double)from[k]);
    }
    if (model->is_radial) {
        const double length = (double)group->rest[lane], now = ss_norm3(d);
        const double wanted = fmin(fmax(now, (1.0 - alpha) * length), (1.0 + alpha) * length);
        const bool is_coincident = !(now > 1e-9 * length);
        ss_scale3(to, is_coincident ? rest : d, wanted / (is_coincident ? length : now));
    } else {
        const double sum = fabs(rest[0]) + fabs(rest[1]) + fabs(rest[2]);
        for (int k = 0; k < 3; ++k) {
            const double slack = alpha * fabs(rest[k]) + model->beta * (sum - fabs(rest[k]));
            to[k] = fmin(fmax(d[k], rest[k] - slack), rest[k] + slack);
        }
    }
    ss_sub3(way, to, d);
    for (int k = 0; k < 3; ++k) {
        out_u[k] = (double)own[k] + way[k];
    }
    return ss_norm3(way);
}

static bool may_move(const ss_model *model, int32_t node)
{
    return !model->has_moved[node] && model->bound[node] != 7;
}

/* Rounding alone moves nobody. */
static bool is_violation(const ss_model *model, double violation)
{
    return violation > (sizeof(ss_real) == sizeof(float) ? 1e-6 : 1e-13) * model->net->mean_length;
}

/* ---- order ---- */

static void propagate_in_turn(ss_model *model)
{
    const ss_chain_net *net = model->net;
    for (int32_t next = 0; next < model->queue_count; ++next) {
        const int32_t node = model->queue[next];
        for (int32_t p = net->first[node]; p < net->first[node + 1]; ++p) {
            const int32_t other = ss_chain_other(net, net->at[p], node);
            double u[3];
            if (may_move(model, other) &&
                is_violation(model, place_by(model, net->at[p], other, node, u))) {
                ss_mail_move_to(model, other, u);
                ss_mail_sponsor(model, other);
            }
        }
    }
}

/* Before: larger violation, then lower node and sponsor, so that the order never depends on the
 * heap's history. */
static bool is_before(const ss_mail_request *a, const ss_mail_request *b)
{
    if (a->violation != b->violation) {
        return a->violation > b->violation;
    }
    return a->node != b->node ? a->node < b->node : a->sponsor < b->sponsor;
}

static void heap_push(ss_model *model, ss_mail_request r)
{
    int32_t at = model->heap_count++;
    while (at > 0 && is_before(&r, &model->heap[(at - 1) / 2])) {
        model->heap[at] = model->heap[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    model->heap[at] = r;
}

static ss_mail_request heap_pop(ss_model *model)
{
    const ss_mail_request top = model->heap[0], last = model->heap[--model->heap_count];
    int32_t at = 0;
    for (;;) {
        int32_t child = 2 * at + 1;
        if (child >= model->heap_count) {
            break;
        }
        if (child + 1 < model->heap_count &&
            is_before(&model->heap[child + 1], &model->heap[child])) {
            ++child;
        }
        if (!is_before(&model->heap[child], &last)) {
            break;
        }
        model->heap[at] = model->heap[child];
        at = child;
    }
    model->heap[at] = last;
    return top;
}

/* What a node that has moved asks of its neighbours. Each link asks at most once. */
static void ask_neighbours(ss_model *model, int32_t node)
{
    const ss_chain_net *net = model->net;
    for (int32_t p = net->first[node]; p < net->first[node + 1]; ++p) {
        const int32_t other = ss_chain_other(net, net->at[p], node);
        double u[3];
        if (may_move(model, other)) {
            const double violation = place_by(model, net->at[p], other, node, u);
            if (is_violation(model, violation)) {
                heap_push(model, (ss_mail_request){violation, other, node});
            }
        }
    }
}

static int32_t link_between(const ss_chain_net *net, int32_t node, int32_t other)
{
    int32_t p = net->first[node];
    while (ss_chain_other(net, net->at[p], node) != other) {
        ++p;
    }
    return net->at[p];
}

static void propagate_by_violation(ss_model *model)
{
    model->heap_count = 0;
    for (int32_t k = 0; k < model->queue_count; ++k) {
        ask_neighbours(model, model->queue[k]);
    }
    while (model->heap_count > 0) {
        const ss_mail_request next = heap_pop(model);
        if (may_move(model, next.node)) {
            double u[3];
            (void)place_by(model, link_between(model->net, next.node, next.sponsor), next.node,
                           next.sponsor, u);
            ss_mail_move_to(model, next.node, u);
            ss_mail_sponsor(model, next.node);
            ask_neighbours(model, next.node);
        }
    }
}

static void propagate(ss_model *model)
{
    if (model->is_by_violation) {
        propagate_by_violation(model);
    } else {
        propagate_in_turn(model);
    }
    model->moved_count += model->queue_count;
    for (int32_t k = 0; k < model->queue_count; ++k) {
        model->has_moved[model->queue[k]] = 0;
    }
    model->queue_count = 0;
}

static void relax(ss_model *model)
{
    const ss_chain_net *net = model->net;
    for (int32_t i = 0; i < model->node_count; ++i) {
        const int32_t degree = net->first[i + 1] - net->first[i];
        double mean[3] = {0.0, 0.0, 0.0};
        if (degree == 0 || model->held[i] != 0 || !may_move(model, i)) {
            continue;
        }
        for (int32_t p = net->first[i]; p < net->first[i + 1]; ++p) {
            const ss_real *u = model->u + 4 * (ptrdiff_t)ss_chain_other(net, net->at[p], i);
            for (int k = 0; k < 3; ++k) {
                mean[k] += (double)u[k] / degree;
            }
        }
        ss_mail_move_to(model, i, mean);
    }
}

/* ---- sponsors ---- */

static void move_prescribed(ss_model *model, double time)
{
    for (int32_t s = 0; s < model->plan.prescribed_count; ++s) {
        const ss_prescribed *set = &model->plan.prescribed[s];
        const double share = ss_plan_ramp(set->from, set->ramp, time);
        for (int32_t i = 0; i < set->node_count; ++i) {
            bool is_moving = false;
            for (int k = 0; k < 3; ++k) {
                ss_real *u = &model->u[4 * (ptrdiff_t)set->node[i] + k];
                if (ss_plan_is_prescribed(set, i, k)) {
                    const ss_real to = (ss_real)(share * set->displacement[i][k]);
                    is_moving = is_moving || to != *u;
                    *u = to;
                }
            }
            if (is_moving) {
                ss_mail_sponsor(model, set->node[i]);
            }
        }
    }
}

static void step(ss_model *model, double time, double dt,
                 const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    if (!ss_model_begin(&model->verdict, &model->reason, dt)) {
        return;
    }
    model->worst = -1;
    const int32_t parts = ss_mail_tools_take(model, tool);
    model->moved_count = 0;
    memset(model->held, 0, (size_t)model->node_count);
    ss_mail_refit(model, model->step);
    for (int32_t p = 1; p <= parts; ++p) {
        move_prescribed(model, time + dt * p / parts);
        ss_mail_tools_move(model, (double)p / parts);
        propagate(model);
    }
    ss_mail_tools_grasp(model, tool);
    for (int32_t n = 0; n < model->iterations; ++n) {
        relax(model);
    }
    ss_mail_refit(model, model->step + 1);
    ss_mail_tools_measure(model);
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)model->node_count; ++at) {
        if (!isfinite(model->u[at])) {
            memset(model->u, 0, 4 * (size_t)model->node_count * sizeof *model->u);
            model->verdict = SOFTSIM_VERDICT_FAULT;
            model->reason = "not finite: back at rest, waiting for reset";
            return;
        }
    }
    const int32_t t = ss_inverted_look(&model->inverted, model->u);
    if (t >= 0) {
        model->worst = model->plan.mesh->tetrahedron[t][0];
        model->verdict = SOFTSIM_VERDICT_DEGRADED;
        model->reason = SS_INVERTED_REASON;
    }
    ++model->step;
}

/* ---- set-up ---- */

static softsim_status check(const ss_model_plan *plan, softsim_error *error)
{
    const int32_t before = error->fault_count;
    if (ss_norm3(plan->gravity) > 0.0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "chainmail: gravity_m_s2: there is no mass in a chain: leave it out");
    }
    if (plan->load_count > 0) {
        softsim_error_add(error, SOFTSIM_ERROR_SCENE,
                          "chainmail: loads: there is no force in a chain: prescribe "
                          "displacements instead");
    }
    return error->fault_count > before ? SOFTSIM_ERROR_SCENE : SOFTSIM_OK;
}

static softsim_status allocate(ss_model *model)
{
    const size_t n = (size_t)model->node_count, links = (size_t)model->net->link_count;
    ss_arena *arena = &model->arena;
    SS_ARENA_TAKE(arena, SS_ROOM((size_t)model->net->group_count * SS_CHAIN_LANES, model->alpha),
                  SS_ROOM(4 * n, model->u), SS_ROOM(4 * n, model->v), SS_ROOM(4 * n, model->push),
                  SS_ROOM(n, model->weight), SS_ROOM(n, model->has_moved), SS_ROOM(n, model->bound),
                  SS_ROOM(n, model->held), SS_ROOM(n, model->queue),
                  SS_ROOM(model->is_by_violation ? 2 * links : 0, model->heap));
    return ss_arena_status(arena);
}

static void set_material(ss_model *model)
{
    const ss_model_plan *plan = &model->plan;
    const ss_chain_net *net = model->net;
    for (int32_t e = 0; e < net->link_count; ++e) {
        model->alpha[net->position[e]] =
            0.5 * (ss_plan_node_value(&plan->param[SS_MAIL_ALPHA], net->link[e][0]) +
                   ss_plan_node_value(&plan->param[SS_MAIL_ALPHA], net->link[e][1]));
    }
    for (int32_t i = 0; i < model->node_count; ++i) {
        model->bound[i] = plan->fixed[i] & 7;
    }
    for (int32_t s = 0; s < plan->prescribed_count; ++s) {
        const ss_prescribed *set = &plan->prescribed[s];
        for (int32_t i = 0; i < set->node_count; ++i) {
            for (int k = 0; k < 3; ++k) {
                if (ss_plan_is_prescribed(set, i, k)) {
                    model->bound[set->node[i]] |= (uint8_t)(1u << k);
                }
            }
        }
    }
}

static softsim_status build_on(ss_model *model, softsim_error *error)
{
    const ss_model_plan *plan = &model->plan;
    double *size = ss_memory_get((size_t)model->node_count, sizeof *size);
    softsim_status status = size ? check(plan, error) : SOFTSIM_ERROR_MEMORY;
    if (size) {
        const softsim_status checked =
            ss_plan_check(plan, "chainmail", size, NULL, &model->is_held, error);
        status = status == SOFTSIM_OK ? checked : status;
    }
    ss_memory_free(size);
    status = status == SOFTSIM_OK
                 ? ss_chain_net_create(plan->mesh, "chainmail", &model->arena, &model->net, error)
                 : status;
    status = status == SOFTSIM_OK ? allocate(model) : status;
    if (status == SOFTSIM_OK) {
        set_material(model);
        status = ss_mail_tools_create(model, error);
    }
    return status;
}

/* ---- the class ---- */

static void destroy(ss_model *model)
{
    ss_tools_fini(&model->tools);
    ss_arena_free(&model->arena);
    ss_memory_free(model);
}

static void reset(ss_model *model)
{
    memset(model->u, 0, 4 * (size_t)model->node_count * sizeof *model->u);
    memset(model->held, 0, (size_t)model->node_count);
    ss_tools_reset(&model->tools);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        ss_mail_tool_clear(&model->tool[k]);
    }
    model->step = 0;
    model->fitted_step = -1;
    model->moved_count = 0;
    ss_inverted_reset(&model->inverted);
    model->worst = -1;
    model->verdict = SOFTSIM_VERDICT_GOOD;
    model->reason = "";
}

static softsim_status build(ss_model *model, const ss_model_plan *plan, softsim_error *error)
{
    model->plan = *plan;
    model->node_count = plan->mesh->node_count;
    ss_inverted_init(&model->inverted, plan->mesh, plan->step);
    model->beta = plan->param[SS_MAIL_BETA].number;
    model->is_radial = plan->param[SS_MAIL_BAND].number != 0.0;
    model->is_by_violation = plan->param[SS_MAIL_ORDER].number != 0.0;
    model->iterations = (int32_t)plan->param[SS_MAIL_RELAXATION_ITERATIONS].number;
    const softsim_status status = build_on(model, error);
    model->plan.param = NULL;
    if (status == SOFTSIM_OK) {
        reset(model);
    }
    return status;
}

/* Microseconds of a link that is tested, in propagation and in a pass of relaxation, and of a tool;
 * liver of 5762 nodes, reference core. A step is planned to reach a fifth of the links. */
#define COST_LINK  0.01
#define COST_RELAX 0.003
#define COST_TOOL  80.0

static double step_cost_us(const ss_model_plan *plan)
{
    const double links = plan->mesh->tetrahedron_count > 0
                             ? plan->mesh->node_count + 1.3 * plan->mesh->tetrahedron_count
                             : 3.0 * plan->mesh->node_count;
    return 1.0 + COST_TOOL * ss_plan_tool_count(plan) + 0.2 * COST_LINK * links +
           2.0 * COST_RELAX * links * plan->param[SS_MAIL_RELAXATION_ITERATIONS].number;
}

static void info(const ss_model *model, ss_model_info *out)
{
    *out = (ss_model_info){
        .step = model->step,
        .substeps = 1,
        .active_nodes = model->moved_count,
        .worst_element = model->worst,
        .fault_bits = model->verdict == SOFTSIM_VERDICT_FAULT ? SS_MODEL_FAULT_NOT_FINITE : 0,
        .verdict = model->verdict,
        .reason = model->reason,
        .stable_step = (double)INFINITY,
        .travelled = 1.0};
}

static const ss_real *displacement(const ss_model *model)
{
    return model->u;
}

static const ss_real *velocity(const ss_model *model)
{
    return model->v;
}

/* There is no force in a chain. */
static void reaction(const ss_model *model, int32_t set, double out_force[3])
{
    (void)model;
    (void)set;
    ss_set3(out_force, 0.0, 0.0, 0.0);
}

static uint64_t hash_state(const ss_model *model, uint64_t seed)
{
    uint64_t hash = ss_inverted_hash(&model->inverted, seed);
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_tool *tool = &model->tools.tool[k];
        const ss_grasp *grasp = &tool->grasp;
        const size_t count = (size_t)grasp->count;
        if (tool->is_used) {
            hash = ss_hash_bytes(hash, &count, sizeof count);
            const ss_mail_tool *own = &model->tool[k];
            hash = ss_hash_bytes(hash, &own->e, sizeof own->e);
            hash = ss_hash_bytes(hash, &own->dent, sizeof own->dent);
            hash = ss_hash_bytes(hash, own->normal, sizeof own->normal);
            hash = ss_hash_bytes(hash, own->arm, sizeof own->arm);
        }
        if (count > 0) {
            hash = ss_hash_bytes(hash, grasp->node, count * sizeof *grasp->node);
            hash = ss_hash_bytes(hash, grasp->offset, count * sizeof *grasp->offset);
        }
    }
    return hash;
}

static void explain(const ss_model *model, const ss_notes *out)
{
    ss_note_used(out, "chain", "%d elements, %d links, each once, mean %.4g m", model->node_count,
                 model->net->link_count, model->net->mean_length);
    ss_note_used(out, "band", "%s; order: %s; relaxation: %d passes a step",
                 model->is_radial ? "radial" : "box",
                 model->is_by_violation ? "largest violation first" : "first in, first out",
                 model->iterations);
    ss_tools_warn_unheld(&model->tools, model->is_held, out);
    ss_tools_warn_rounded(&model->tools, &model->plan, out);
    if (model->plan.contact_stiffness > 0.0) {
        ss_note_warning(out, "contact.stiffness_n_per_m3",
                        "not used: chainmail has no contact stiffness, and the felt stiffness is "
                        "the working force over the tool's radius; give contact.working_force_n "
                        "instead");
    }
    ss_note_left_out(out, "forces, energies, reactions", NULL,
                     "there are none in a chain; the hand feels a spring: working force / tool "
                     "radius, times the dent");
}

static void write_case(FILE *file, const ss_model_class *model, const ss_hints_setting *setting)
{
    (void)model;
    fprintf(file, "  alpha: %.9g\n  beta: %.9g\n  relaxation_iterations: 20\n", setting->free[0],
            setting->free[1]);
}

static const ss_hints_variant variant = {.name = "chainmail", .text = "", .is_plastic = true};
static const ss_model_hints hints = {
    .colour = "#7a7a7a",
    .about = "geometry alone: distances are kept within bounds, forces do not exist in it",
    .free_count = 2,
    .free = {{"alpha", 5e-3, 0.5, 0.1}, {"beta", 0.02, 1.0, 0.2}},
    .write = write_case,
    .variant = &variant,
    .variant_count = 1};

SS_MODEL_CLASS(ss_model_chainmail, "chainmail",
               "the traditional ChainMail: chain elements move only where links leave their band",
               SS_MODEL_PARTS(ss_model, &hints, rows, step_cost_us, build, destroy, step, explain),
               SS_MODEL_STATE(ss_mail_contacts, reset, info, displacement, velocity, reaction,
                              hash_state),
               .has_no_energy = true, .grasps_without_force = true);
