/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/sleep.h"
/*
 * What counts as rest. With D the body's diagonal, h the step, x_q the nodes as quarter q of a
 * second begins, m_q their mean places and F_q the mean force on a tool in it, four quarters on end
 * are still when
 *
 *   |x - x_q| <= d,  |v| <= max(1e-3 D / s, d / h)  in each of their steps,  d = 6.25e-6 D,
 *   |m_q - m_1| <= w 3 t_q / T,  |F_q - F_1| <= f 3 t_q / T,  q = 2, 3, 4,  w = 1.5e-5 D,
 *
 * t_q = 0.25 s, T = 4 s. What creeps with a time constant of up to T is then within w, and its
 * force within f, of where it would come to rest for good; f is a thousandth of what is just
 * noticeable, which is 7 % of a force and at least 20 mN. A swift press on slow
 * tissue is answered by the contact's own stiffness, so places count: put to sleep with 1e-4 D to
 * go, a block's next press differed from the run without sleep by 2e-3 of the largest force. With
 * an eighth of w, what a tool presses stayed awake for seconds where a solver's tolerance lets it
 * wander. Creep slower than T is cut short: for time constants of 20 s the next press differed by
 * 2e-3.
 *
 * The last digits of a force in floats never rest: hence means of a quarter, whose change is looked
 * at over three (from each to the next, 4e-6 of a force, a block of 60 kPa stayed awake); within a
 * quarter it may swing by 5 f: more is a motion that no mean shows. Nor do nodes rest: light ones
 * tremble by 10 nm at some kilohertz in rounded forces, all by 0.2 um where a solver stops at its
 * tolerance: hence d, and d / h, less than which leaves no step's place by d. A guard that acts in
 * every step of the four quarters, while no tool moves, does not keep the body awake, and its
 * verdict is told on.
 *
 * Torques count as forces at the tool's bounding radius R. The stiffness that is told, which some
 * models find over seconds, is within 5e-3 of where it ends in the same way. A tool that touches or
 * is near may move by f over its stiffness, turns counted at R: also those of a sphere, which
 * nothing feels but what it grasps or rubs.
 */
#include <math.h>
#include <string.h>

#include "rt/memory.h"
#include "rt/vec.h"

enum { QUARTERS = 4 };
#define QUARTER          0.25    /* s */
#define CREEP_TIME       4.0     /* s, T */
#define STILL_WAY        1.5e-5  /* of the diagonal, w */
#define TREMBLE          6.25e-6 /* of the diagonal, d */
#define AIR_WAY          1e-4    /* of the diagonal: of a tool that touches nothing */
#define STILL_SPEED      1e-3    /* of the diagonal, 1/s */
#define STILL_STIFFNESS  5e-3    /* of itself */
#define MOST_SWING       5.0     /* times the still force, within a quarter */
#define NOTICEABLE_SHARE 0.07    /* of the force */
#define NOTICEABLE_FORCE 0.02    /* N */
#define STILL_NOTICEABLE 1e-3    /* of what is just noticeable */
/* Of a tool's way: what the stiffness that was told leaves unanswered, which the haptic loop
 * follows the tool with meanwhile. Nothing follows its turns. */
#define UNANSWERED 0.1
/* Of `near`: a tool in the air that comes nearer than that much more wakes the model, so that its
 * distance is not looked up for each little way. */
#define NEAR_MORE 0.5

typedef struct ss_sleep_tool {
    ss_tool_pose pose; /* at the start of the quarter; asleep: where it was when last looked at */
    double way;        /* m, that it may move there while nothing changes */
    double clearance;  /* m, from its pose there to the nearest node, less slack; of a free one */
    double radius;     /* m, bounding */
    bool is_present, is_grasping, is_free;
    bool is_near;          /* of the last set: a contact, or a patch that is near */
    int32_t still;         /* quarters on end */
    double first_force[3]; /* N, of the quarter */
    double force[3];       /* N, summed over the quarter, at its end the mean */
    double torque[3];      /* N m, the same */
    double base_force[3];  /* N, mean of the first still quarter */
    double base_torque[3]; /* N m, the same */
    double base_stiffness; /* N/m, along the normals, at the end of that */
    double stiffness;      /* N/m, of the last set */
} ss_sleep_tool;

struct ss_sleep {
    const ss_model_class *model_class;
    ss_model *model;
    const ss_load *load;
    const ss_prescribed *prescribed;
    int32_t load_count, prescribed_count;
    const ss_mesh *mesh; /* as the model has it */
    double step, diagonal;
    int32_t quarter; /* steps */
    ss_real *place;  /* displacements at the start of the quarter */
    ss_real *sum;    /* from there, over the quarter; at its end the mean displacements */
    ss_real *base;   /* mean displacements in the first still quarter */
    /* state */
    int32_t steps;           /* of this quarter, so far */
    int32_t quarters;        /* still, on end */
    int32_t moving;          /* the node that moved last: it is looked at first */
    softsim_verdict verdict; /* of the last step */
    bool is_asleep;
    int64_t slept; /* steps */
    double until;  /* s */
    double slack;  /* m: between nodes there is surface */
    ss_sleep_tool tool[SOFTSIM_MAX_PROBES];
};

/* ---- set-up ---- */

ss_sleep *ss_sleep_create(const ss_model_class *model_class, ss_model *model,
                          const ss_model_plan *plan)
{
    ss_sleep *sleep = ss_memory_get(1, sizeof *sleep);
    if (sleep == NULL) {
        return NULL;
    }
    ss_model_shape shape = {.mesh = plan->mesh, .fixed = plan->fixed};
    if (model_class->shape != NULL) {
        model_class->shape(model, &shape);
    }
    *sleep = (ss_sleep){.model_class = model_class,
                        .model = model,
                        .load = plan->load,
                        .load_count = plan->load_count,
                        .prescribed = plan->prescribed,
                        .prescribed_count = plan->prescribed_count,
                        .mesh = shape.mesh,
                        .step = plan->step,
                        .diagonal = ss_mesh_diagonal(plan->mesh),
                        .quarter = (int32_t)ceil(QUARTER / plan->step)};
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        if (plan->tool[p].is_used) {
            sleep->tool[p].radius = ss_shape_bounding_radius(&plan->tool[p].shape);
        }
    }
    const size_t count = 4 * (size_t)shape.mesh->node_count;
    sleep->place = ss_memory_get(3 * count, sizeof *sleep->place);
    if (sleep->place == NULL) {
        ss_sleep_destroy(&sleep);
        return NULL;
    }
    sleep->sum = sleep->place + count;
    sleep->base = sleep->sum + count;
    return sleep;
}

void ss_sleep_destroy(ss_sleep **sleep)
{
    if (*sleep != NULL) {
        ss_memory_free((*sleep)->place);
        ss_memory_free(*sleep);
        *sleep = NULL;
    }
}

/* ---- nodes ---- */

static double square4(const ss_real *v)
{
    return (double)(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Is any node faster? Looks first at the one that was, so that a body that moves costs nothing. */
static bool is_moving(ss_sleep *sleep)
{
    const ss_real *v = sleep->model_class->velocity(sleep->model);
    const double limit = fmax(STILL_SPEED, TREMBLE / sleep->step) * sleep->diagonal;
    const double square = limit * limit;
    if (!(square4(v + 4 * (ptrdiff_t)sleep->moving) <= square)) {
        return true;
    }
    for (int32_t i = 0; i < sleep->mesh->node_count; ++i) {
        if (!(square4(v + 4 * (ptrdiff_t)i) <= square)) {
            sleep->moving = i;
            return true;
        }
    }
    return false;
}

static void begin_quarter(ss_sleep *sleep)
{
    const size_t size = 4 * (size_t)sleep->mesh->node_count * sizeof *sleep->place;
    memcpy(sleep->place, sleep->model_class->displacement(sleep->model), size);
    memset(sleep->sum, 0, size);
}

/* Is any node further from where it was when this quarter began than one that trembles? */
static bool has_gone(ss_sleep *sleep)
{
    const ss_real *u = sleep->model_class->displacement(sleep->model);
    const double limit = TREMBLE * sleep->diagonal;
    const double square = limit * limit;
    bool is_any = false;
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)sleep->mesh->node_count && !is_any; at += 4) {
        ss_real way[3];
        for (int k = 0; k < 3; ++k) {
            way[k] = u[at + k] - sleep->place[at + k];
            sleep->sum[at + k] += way[k];
        }
        is_any = !(square4(way) <= square);
    }
    return is_any;
}

/* At the end of a quarter: makes means of the sums; has any crept from the first still quarter's?
 */
static bool has_crept(ss_sleep *sleep)
{
    const double share = (QUARTERS - 1) * sleep->quarter * sleep->step / CREEP_TIME;
    const double limit = share * STILL_WAY * sleep->diagonal;
    const ss_real part = (ss_real)(1.0 / sleep->quarter);
    bool is_any = false;
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)sleep->mesh->node_count; at += 4) {
        ss_real way[3];
        for (int k = 0; k < 3; ++k) {
            sleep->sum[at + k] = sleep->place[at + k] + part * sleep->sum[at + k];
            way[k] = sleep->sum[at + k] - sleep->base[at + k];
        }
        is_any = is_any || !(square4(way) <= limit * limit);
    }
    return is_any;
}

static void place_of(const ss_sleep *sleep, const ss_real *u, int32_t node, double out[3])
{
    for (int k = 0; k < 3; ++k) {
        out[k] = sleep->mesh->position[node][k] + (double)u[4 * (ptrdiff_t)node + k];
    }
}

/* The longest side of the surface: none of its points is further from all nodes, and a surface that
 * is rounded over a triangle stays within half of one. */
static double longest_side(const ss_sleep *sleep)
{
    const ss_real *u = sleep->model_class->displacement(sleep->model);
    double longest = 0.0;
    for (int32_t t = 0; t < sleep->mesh->triangle_count; ++t) {
        double corner[3][3];
        for (int c = 0; c < 3; ++c) {
            place_of(sleep, u, sleep->mesh->triangle[t][c], corner[c]);
        }
        for (int c = 0; c < 3; ++c) {
            double side[3];
            ss_sub3(side, corner[(c + 1) % 3], corner[c]);
            longest = fmax(longest, ss_dot3(side, side));
        }
    }
    return sqrt(longest);
}

/* No part of tool `p` at `x` is nearer to the body than this, m; below 0: it may be anywhere. */
static double clearance(const ss_sleep *sleep, int32_t p, const double x[3])
{
    const ss_real *u = sleep->model_class->displacement(sleep->model);
    double least = INFINITY;
    for (int32_t i = 0; i < sleep->mesh->node_count; ++i) {
        double way[3], node[3];
        place_of(sleep, u, i, node);
        ss_sub3(way, node, x);
        least = fmin(least, ss_dot3(way, way));
    }
    return sqrt(least) - sleep->tool[p].radius - sleep->slack;
}

/* ---- loads and supports that change ---- */

/* Something that begins at `from` and is done `ramp` later: does it go on at `time`, and else until
 * when does it not? */
static bool changes(double from, double ramp, double time, double margin, double *until)
{
    if (time < from - margin) {
        *until = fmin(*until, from - margin);
        return false;
    }
    return time <= from + ramp + margin;
}

/* Do loads or supports change at `time`? If not, sets `until`. */
static bool is_driven(ss_sleep *sleep, double time)
{
    const double margin = 2.0 * sleep->step;
    bool is_any = false;
    sleep->until = INFINITY;
    for (int32_t k = 0; k < sleep->load_count; ++k) {
        const ss_load *load = &sleep->load[k];
        if (!ss_load_pushes(load)) {
            continue;
        }
        is_any = is_any || changes(load->from, load->ramp, time, margin, &sleep->until) ||
                 changes(load->to, 0.0, time, margin, &sleep->until);
    }
    for (int32_t k = 0; k < sleep->prescribed_count; ++k) {
        const ss_prescribed *set = &sleep->prescribed[k];
        is_any = is_any || changes(set->from, set->ramp, time, margin, &sleep->until);
    }
    return is_any;
}

/* ---- tools ---- */

/* N: a thousandth of the change that a hand just notices. */
static double still_force(const double force[3])
{
    return STILL_NOTICEABLE * fmax(NOTICEABLE_FORCE, NOTICEABLE_SHARE * ss_norm3(force));
}

/* How far the tool has come, m: `share` of its way, and how far it has turned, a sphere too. */
static double moved(const ss_sleep_tool *tool, const ss_tool_pose *pose, double share)
{
    double way[3], turn[3];
    ss_sub3(way, pose->position, tool->pose.position);
    ss_turn_between(tool->pose.orientation, pose->orientation, turn);
    return share * ss_norm3(way) + tool->radius * ss_norm3(turn);
}

/* What the set makes the hand feel (N): the model's force, and of a model without forces that of
 * its contacts. Returns the stiffness along the normals, N/m, and the stiffest of all that is told.
 */
static double read_set(const ss_contact_set *set, double out_force[3], double *out_stiffest)
{
    double along = 0.0, aside = 0.0, swift = 0.0, pushed[3] = {0.0, 0.0, 0.0};
    for (int32_t k = 0; k < set->count; ++k) {
        const ss_contact *contact = &set->contact[k];
        along += contact->stiffness;
        aside += contact->tangential;
        swift += contact->swift;
        ss_madd3(pushed, pushed, contact->force, contact->normal);
    }
    ss_copy3(out_force, ss_norm3(set->force) > 0.0 ? set->force : pushed);
    *out_stiffest = fmax(fmax(along, aside), fmax(swift, set->step_stiffness));
    return along;
}

/* Takes over what a step told of the tool; false where it came, went, grasped, let go or moved. */
static bool is_tool_still(ss_sleep *sleep, int32_t p, const ss_model_tool *input,
                          const ss_contact_set *set)
{
    ss_sleep_tool *tool = &sleep->tool[p];
    const bool is_same =
        tool->is_present == input->is_present && tool->is_grasping == input->is_grasping;
    tool->is_present = input->is_present;
    tool->is_grasping = input->is_grasping;
    if (!tool->is_present) {
        return is_same;
    }
    double force[3], stiffest, apart[3];
    tool->stiffness = read_set(set, force, &stiffest);
    tool->is_near = set->count > 0 || ss_norm3(set->force) > 0.0;
    tool->way =
        tool->is_near && stiffest > 0.0 ? still_force(force) / stiffest : AIR_WAY * sleep->diagonal;
    if (sleep->steps == 0) {
        tool->pose = input->from;
        ss_copy3(tool->first_force, force);
        ss_set3(tool->force, 0.0, 0.0, 0.0);
        ss_set3(tool->torque, 0.0, 0.0, 0.0);
    }
    ss_add3(tool->force, tool->force, force);
    ss_add3(tool->torque, tool->torque, set->torque);
    ss_sub3(apart, force, tool->first_force);
    const bool has_moved = moved(tool, &input->to, UNANSWERED) > tool->way;
    tool->still = has_moved ? 0 : tool->still;
    /* One in the air is judged when all else rests. */
    return is_same && !(has_moved && tool->is_near) &&
           ss_norm3(apart) <= MOST_SWING * still_force(force);
}

/* At the end of a quarter: is the force on the tool where it was in the first still one? */
static bool is_force_still(const ss_sleep *sleep, const ss_sleep_tool *tool)
{
    double by_force[3], by_torque[3];
    const double share = (QUARTERS - 1) * sleep->quarter * sleep->step / CREEP_TIME;
    const double limit = share * still_force(tool->force);
    ss_sub3(by_force, tool->force, tool->base_force);
    ss_sub3(by_torque, tool->torque, tool->base_torque);
    return ss_norm3(by_force) <= limit && ss_norm3(by_torque) <= limit * tool->radius &&
           fabs(tool->stiffness - tool->base_stiffness) <=
               share * STILL_STIFFNESS * tool->base_stiffness;
}

/* Is tool `p` so far away, or so still, that the body may sleep? */
static bool lets_sleep(ss_sleep *sleep, int32_t p, const ss_model_tool *input, double near)
{
    ss_sleep_tool *tool = &sleep->tool[p];
    tool->is_free = false;
    if (!tool->is_present) {
        return true;
    }
    if (!tool->is_near && !tool->is_grasping) {
        tool->clearance = clearance(sleep, p, input->to.position);
        tool->is_free = tool->clearance > (1.0 + NEAR_MORE) * near;
    }
    tool->pose = input->to;
    return (tool->is_free && sleep->verdict == SOFTSIM_VERDICT_GOOD) || tool->still >= QUARTERS;
}

/* ---- falling asleep and waking ---- */

bool ss_sleep_is_asleep(const ss_sleep *sleep)
{
    return sleep->is_asleep;
}

void ss_sleep_wake(ss_sleep *sleep)
{
    if (sleep->is_asleep && sleep->model_class->slept != NULL) {
        sleep->model_class->slept(sleep->model, sleep->slept);
    }
    sleep->is_asleep = false;
    sleep->slept = 0;
    sleep->steps = sleep->quarters = 0;
}

void ss_sleep_skip(ss_sleep *sleep, int64_t count)
{
    sleep->slept += count;
}

bool ss_sleep_is_tool_free(const ss_sleep *sleep, int32_t probe)
{
    return sleep->tool[probe].is_free;
}

double ss_sleep_until(const ss_sleep *sleep)
{
    return sleep->until;
}

static bool stays_clear(ss_sleep *sleep, int32_t p, const ss_model_tool *input, double near)
{
    ss_sleep_tool *tool = &sleep->tool[p];
    if (tool->clearance - moved(tool, &input->to, 1.0) > near) {
        return true;
    }
    tool->clearance = clearance(sleep, p, input->to.position);
    tool->pose = input->to;
    return tool->clearance > (1.0 + NEAR_MORE) * near;
}

bool ss_sleep_goes_on(ss_sleep *sleep, double time, const ss_model_tool tool[SOFTSIM_MAX_PROBES],
                      const double near[SOFTSIM_MAX_PROBES])
{
    bool goes_on = sleep->is_asleep && time < sleep->until;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES && goes_on; ++p) {
        const ss_sleep_tool *own = &sleep->tool[p];
        goes_on =
            tool[p].is_present == own->is_present && tool[p].is_grasping == own->is_grasping &&
            (!own->is_present || (own->is_free ? stays_clear(sleep, p, &tool[p], near[p])
                                               : moved(own, &tool[p].to, UNANSWERED) <= own->way));
    }
    if (goes_on) {
        ++sleep->slept;
    } else if (sleep->is_asleep) {
        ss_sleep_wake(sleep);
    }
    return goes_on;
}

bool ss_sleep_has_tool(const ss_sleep *sleep)
{
    bool is_any = false;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        is_any = is_any || sleep->tool[p].is_present;
    }
    return is_any;
}

/* A quarter is over: returns how many are still on end. Nodes were looked at in each step. */
static int32_t end_quarter(ss_sleep *sleep)
{
    bool is_still = !has_crept(sleep) && sleep->quarters > 0;
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        ss_sleep_tool *tool = &sleep->tool[p];
        if (tool->is_present) {
            ss_scale3(tool->force, tool->force, 1.0 / sleep->quarter);
            ss_scale3(tool->torque, tool->torque, 1.0 / sleep->quarter);
            is_still = is_still && is_force_still(sleep, tool);
            ++tool->still;
        }
    }
    if (is_still) {
        return sleep->quarters + 1;
    }
    memcpy(sleep->base, sleep->sum, 4 * (size_t)sleep->mesh->node_count * sizeof *sleep->base);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        ss_sleep_tool *tool = &sleep->tool[p];
        ss_copy3(tool->base_force, tool->force);
        ss_copy3(tool->base_torque, tool->torque);
        tool->base_stiffness = tool->stiffness;
    }
    return 1;
}

static void fall_asleep(ss_sleep *sleep, const ss_model_tool tool[SOFTSIM_MAX_PROBES],
                        const double near[SOFTSIM_MAX_PROBES])
{
    bool may_sleep = true;
    sleep->slack = longest_side(sleep);
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        may_sleep = lets_sleep(sleep, p, &tool[p], near[p]) && may_sleep;
    }
    sleep->is_asleep = may_sleep;
}

void ss_sleep_watch(ss_sleep *sleep, double time, const ss_model_tool tool[SOFTSIM_MAX_PROBES],
                    const double near[SOFTSIM_MAX_PROBES], const ss_model_info *info,
                    const ss_contact_set *const set[SOFTSIM_MAX_PROBES])
{
    const bool is_same_verdict = info->verdict == sleep->verdict;
    sleep->verdict = info->verdict;
    bool is_still = is_same_verdict && info->verdict <= SOFTSIM_VERDICT_GUARDED &&
                    !(info->travelled < 1.0) && !is_driven(sleep, time + sleep->step) &&
                    !is_moving(sleep) && (sleep->steps == 0 || !has_gone(sleep));
    for (int32_t p = 0; p < SOFTSIM_MAX_PROBES; ++p) {
        is_still = is_tool_still(sleep, p, &tool[p], set[p]) && is_still;
    }
    if (!is_still) {
        sleep->steps = sleep->quarters = 0;
        return;
    }
    if (sleep->steps == 0) {
        begin_quarter(sleep);
    }
    if (++sleep->steps < sleep->quarter) {
        return;
    }
    sleep->quarters = end_quarter(sleep);
    sleep->steps = 0;
    if (sleep->quarters >= QUARTERS) {
        fall_asleep(sleep, tool, near);
        sleep->quarters = QUARTERS;
    }
}
