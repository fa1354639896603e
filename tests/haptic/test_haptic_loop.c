/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The haptic tick in closed loop: device and hand, bus, tick, simulation of a tissue.
 *
 * Device and hand (three equal axes, M = m_dev + m_hand, b = b_dev + b_hand, 20 steps of 50 us a
 * tick): v' = (M v + dt (F + k_h (x_h - x) + b_h v_h))/(M + dt b), Coulomb friction, tremor, the
 * pose quantised to 30 um. Tissue: a chain of six masses (30 g), static force K d (1 + d/15 mm),
 * viscosity 1 ms x stiffness, one Maxwell branch of 0.4 K and 0.1 s. The judge is tools/bench's.
 */
#include "common/test.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/latency/session_metrics.h"
#include "common/effort.h"
#include "haptic/haptic.h"
#include "rt/each.h"
#include "rt/hash.h"
#include "rt/random.h"
#include "rt/vec.h"

#define T 1e-3

/* ---- device and hand ---- */

typedef struct body {
    const char *name;
    double device_mass, device_damping, friction; /* kg, N s/m, N */
    double hand_mass, hand_stiffness, hand_damping;
} body;

static const body bodies[3] = {
    {"light/soft", 0.05, 0.05, 0.0, 0.1, 100.0, 2.0},
    {"medium/medium", 0.1, 0.3, 0.03, 0.2, 300.0, 5.0},
    {"heavy/firm", 0.3, 2.0, 0.1, 0.5, 800.0, 20.0},
};

typedef enum script { PRESS, POKE, TAP, HOLD_INSIDE, SCRIPTS } script;
static const char *const script_names[SCRIPTS] = {"press", "poke", "tap", "hold inside"};

typedef struct device {
    body own;
    script script;
    double phase[3][3];
    double x[3], v[3];
    int64_t tick;
} device;

static double smooth5(double u)
{
    u = fmin(1.0, fmax(0.0, u));
    return u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
}

static void hand_target(const device *d, double t, double out[3])
{
    static const double hz[3] = {8.3, 9.7, 11.9}, weight[3] = {0.5, 0.35, 0.15};
    memset(out, 0, 3 * sizeof *out);
    switch (d->script) {
    case PRESS:
        out[0] = 20e-3 * smooth5((t - 0.6) / 0.6);
        out[2] = 4e-3 - 12e-3 * (smooth5((t - 0.1) / 0.4) - smooth5((t - 1.4) / 0.4));
        break;
    case POKE:
        out[2] = 4e-3 - 6e-3 * (1.0 - cos(4.0 * SS_PI * t));
        break;
    case TAP:
        out[2] = 12e-3 * cos(8.0 * SS_PI * t);
        break;
    case HOLD_INSIDE:
    case SCRIPTS:
        out[2] = -10e-3;
        break;
    }
    for (int a = 0; a < 3; ++a) {
        for (int i = 0; i < 3; ++i) {
            out[a] += 50e-6 * weight[i] * sin(2.0 * SS_PI * hz[i] * t + d->phase[a][i]);
        }
    }
}

static void device_start(device *d, const body *own, script task, uint64_t seed)
{
    memset(d, 0, sizeof *d);
    d->own = *own;
    d->script = task;
    for (int a = 0; a < 3; ++a) {
        for (int i = 0; i < 3; ++i) {
            d->phase[a][i] = 2.0 * SS_PI * ss_random_unit(&seed);
        }
    }
    hand_target(d, 0.0, d->x);
}

static double quantise(double x)
{
    return 30e-6 * floor(x / 30e-6 + 0.5);
}

/* One tick under force f; returns the energy taken from the device and hand. */
static double device_step(device *d, const double f[3])
{
    const double dt = T / 20.0;
    const double mass = d->own.device_mass + d->own.hand_mass;
    const double damping = d->own.device_damping + d->own.hand_damping;
    double taken = 0.0;
    for (int j = 1; j <= 20; ++j) {
        double before[3], target[3];
        const double t = (double)d->tick * T + j * dt;
        hand_target(d, t - dt, before);
        hand_target(d, t, target);
        double speed = 0.0;
        for (int a = 0; a < 3; ++a) {
            const double push = d->own.hand_stiffness * (target[a] - d->x[a]) +
                                d->own.hand_damping * (target[a] - before[a]) / dt;
            d->v[a] = (mass * d->v[a] + dt * (f[a] + push)) / (mass + dt * damping);
            speed += d->v[a] * d->v[a];
        }
        speed = sqrt(speed);
        const double slide =
            speed > 0.0 ? fmax(0.0, 1.0 - dt * d->own.friction / (mass * speed)) : 0.0;
        for (int a = 0; a < 3; ++a) {
            d->v[a] *= slide;
            d->x[a] += dt * d->v[a];
            taken -= f[a] * dt * d->v[a];
        }
    }
    ++d->tick;
    return taken;
}

/* ---- tissue ---- */

enum { MASSES = 6 };
#define TISSUE_MASS 0.030
#define HARDENING   0.015
/* Contact stiffness over K: a ball of 5 mm dents by a tenth of its radius at its working force. */
#define CONTACT_RATIO 15.0

/* Node i moves down by u_i from rest; link i joins node i to i + 1, the last one to the ground. */
typedef struct chain {
    double stiffness; /* K */
    double u[MASSES], v[MASSES], maxwell[MASSES];
    double reaction;
} chain;

static double link_force(const chain *c, double e, double rate, double maxwell)
{
    const double k = MASSES * c->stiffness;
    const double hardening = 1.0 + fabs(e) * MASSES / HARDENING;
    return k * e * hardening + 1e-3 * k * rate + maxwell;
}

/* Sinks the tool from depth `from` to `to` (m below the surface at rest) over h. */
static void chain_step(chain *c, double from, double to, double h)
{
    const int count = (int)ceil(h / 25e-6);
    const double dt = h / count;
    const double kc = CONTACT_RATIO * c->stiffness;
    const double mass = TISSUE_MASS / MASSES;
    for (int s = 1; s <= count; ++s) {
        const double tool = from + (to - from) * s / count;
        double force[MASSES] = {0};
        c->reaction = fmax(0.0, kc * (tool - c->u[0]));
        force[0] = c->reaction;
        for (int i = 0; i < MASSES; ++i) {
            const double next = i + 1 < MASSES ? c->u[i + 1] : 0.0;
            const double rate = c->v[i] - (i + 1 < MASSES ? c->v[i + 1] : 0.0);
            c->maxwell[i] += dt * (0.4 * MASSES * c->stiffness * rate - c->maxwell[i] / 0.1);
            const double f = link_force(c, c->u[i] - next, rate, c->maxwell[i]);
            force[i] -= f;
            if (i + 1 < MASSES) {
                force[i + 1] += f;
            }
        }
        for (int i = 0; i < MASSES; ++i) {
            c->v[i] += dt * force[i] / mass;
            c->u[i] += dt * c->v[i];
        }
    }
    c->reaction = fmax(0.0, kc * (to - c->u[0]));
}

/* Tangent of the chain, relaxing branch included (a fast hand meets it), and its contact in series,
 * at the present reaction: K d (1 + d/H) = R. */
static double chain_tangent(const chain *c)
{
    const double d =
        0.5 * HARDENING * (sqrt(1.0 + 4.0 * c->reaction / (c->stiffness * HARDENING)) - 1.0);
    const double k = c->stiffness * (1.4 + 2.0 * d / HARDENING);
    return 1.0 / (1.0 / k + 1.0 / (CONTACT_RATIO * c->stiffness));
}

/* ---- the loop ---- */

enum { MAX_TICKS = 6000 };

typedef struct setting {
    const body *own;
    script script;
    double tissue;  /* N/m, K */
    double rate_hz; /* of the simulation */
    int lag;        /* periods */
    int one_way;    /* ticks of bus, each way */
    int ticks;
    ss_between_steps between_steps;
    bool corrects, is_force_seq_known;
    double stiffness, damping;
} setting;

typedef struct outcome {
    ss_felt felt;
    double net_truth;    /* J, sum over the run */
    double worst_server; /* J */
    double peak_hand_speed, peak_reaction, peak_force;
    double limit, delay_p95_ms;
    uint64_t hash;
    ss_felt_row row[MAX_TICKS];
} outcome;

typedef struct simulation {
    chain tissue;
    double period;
    double last[3]; /* p^ of the step before */
    bool has_last, was_touching;
    int64_t next; /* number of the next step */
    uint32_t teleports;
    ss_simulation_result pending[8];
    int64_t due[8];
    int pending_count;
} simulation;

static void fill_result(simulation *s, const ss_proxy_target *target, const double p[3],
                        double from, double stiff_step, ss_simulation_result *out)
{
    memset(out, 0, sizeof *out);
    out->tick = target->tick;
    out->step = s->next;
    out->period = s->period;
    out->pose_seq = target->pose_seq;
    memcpy(out->proxy, p, sizeof out->proxy);
    out->orientation[0] = 1.0;
    out->velocity[2] = (p[2] + from) / s->period;
    ss_contact_set *set = &out->set;
    const double depth = -p[2];
    const bool touches = s->tissue.reaction > 0.0;
    set->depth = depth - s->tissue.u[0];
    set->normal[2] = 1.0;
    set->point[0] = p[0];
    set->point[2] = -s->tissue.u[0];
    set->force[2] = s->tissue.reaction;
    const double near = 5e-3 + fabs(out->velocity[2]) * 2.0 * s->period;
    if (!touches && -set->depth > near) {
        s->was_touching = false;
        return;
    }
    set->count = 1;
    ss_contact *c = &set->contact[0];
    memcpy(c->point, set->point, sizeof c->point);
    c->normal[2] = 1.0;
    c->force = s->tissue.reaction;
    c->stiffness = chain_tangent(&s->tissue);
    c->gap = touches ? 0.0 : fmax(1e-12, -set->depth);
    c->viscosity =
        touches && s->was_touching ? fmax(0.0, (stiff_step - c->stiffness) * s->period) : 0.0;
    s->was_touching = touches;
}

/* Starts a step when one is due at this tick; its result is due lag periods later. */
static void simulate(simulation *s, const setting *set, const ss_proxy_target *target, int64_t tick)
{
    if ((double)tick * T + 1e-9 < (double)s->next * s->period) {
        return;
    }
    if (!target->is_present) {
        chain_step(&s->tissue, -1.0, -1.0, s->period);
        ++s->next;
        return;
    }
    double p[3];
    ss_haptic_predict(target, set->lag, s->period, p);
    if (!s->has_last || target->teleports != s->teleports) {
        memcpy(s->last, p, sizeof p);
    }
    s->has_last = true;
    s->teleports = target->teleports;
    const double from = -s->last[2];
    chain moved = s->tissue;
    chain_step(&moved, from, -p[2] + 10e-6, s->period);
    chain_step(&s->tissue, from, -p[2], s->period);
    const double stiff_step = (moved.reaction - s->tissue.reaction) / 10e-6;
    ss_simulation_result *slot = &s->pending[s->pending_count];
    fill_result(s, target, p, from, stiff_step, slot);
    s->due[s->pending_count++] = tick - 1 + (int64_t)ceil(set->lag * s->period / T - 1e-9);
    memcpy(s->last, p, sizeof p);
    ++s->next;
}

static bool take_due(simulation *s, int64_t tick, ss_simulation_result *out)
{
    bool is_new = false;
    while (s->pending_count > 0 && s->due[0] <= tick) {
        *out = s->pending[0];
        is_new = true;
        --s->pending_count;
        memmove(&s->pending[0], &s->pending[1], (size_t)s->pending_count * sizeof s->pending[0]);
        memmove(&s->due[0], &s->due[1], (size_t)s->pending_count * sizeof s->due[0]);
    }
    return is_new;
}

/* What a correcting client does with the force in effect. */
static void correct(const softsim_force *force, const double at[3], const double x[3],
                    double out[3])
{
    memcpy(out, force->force, 3 * sizeof *out);
    double normal = 0.0, moved = 0.0;
    for (int a = 0; a < 3; ++a) {
        normal += force->normal[a] * force->force[a];
        moved += force->normal[a] * (x[a] - at[a]);
    }
    if (force->stiffness == 0.0 || normal <= 0.0 || fabs(moved) > 5e-3) {
        return;
    }
    const double want = fmax(0.0, normal - force->stiffness * moved);
    for (int a = 0; a < 3; ++a) {
        out[a] += (want - normal) * force->normal[a];
    }
}

/* The device at tick n: its pose, the newest force that has arrived in effect, its row. */
static void run_device(const setting *set, int n, device *d, softsim_pose *sent,
                       const softsim_force *answer, outcome *out)
{
    softsim_pose *pose = &sent[n];
    const int from = n - 2 * set->one_way - 1;
    const softsim_force *force = from >= 0 && answer[from].seq > 0 ? &answer[from] : NULL;
    *pose = (softsim_pose){.utime_us = 1000 * (int64_t)n,
                           .sender = 1,
                           .seq = n + 1,
                           .force_seq = set->is_force_seq_known && force ? force->seq : -1,
                           .flags = set->corrects ? SOFTSIM_POSE_CORRECTS : 0,
                           .orientation = {1, 0, 0, 0},
                           .velocity = {NAN, NAN, NAN},
                           .applied_force = {NAN, NAN, NAN}};
    for (int a = 0; a < 3; ++a) {
        pose->position[a] = quantise(d->x[a]);
    }
    double applied[3] = {0};
    if (force != NULL) {
        memcpy(applied, force->force, sizeof applied);
        if (set->corrects) {
            correct(force, sent[force->pose_seq - 1].position, pose->position, applied);
        }
    }
    if (set->corrects && n > 0) {
        memcpy(pose->applied_force, out->row[n - 1].f, sizeof pose->applied_force);
    }
    ss_felt_row *row = &out->row[n];
    row->time_s = (double)n * T;
    memcpy(row->x, d->x, sizeof row->x);
    memcpy(row->f, applied, sizeof row->f);
    row->flags = force ? force->flags : 0;
    row->age_us = force ? force->model_age_us : 0;
    out->net_truth += device_step(d, applied);
    out->peak_hand_speed =
        fmax(out->peak_hand_speed, sqrt(d->v[0] * d->v[0] + d->v[1] * d->v[1] + d->v[2] * d->v[2]));
}

static outcome *run(const setting *set)
{
    outcome *out = calloc(1, sizeof *out);
    softsim_pose *sent = calloc(MAX_TICKS, sizeof *sent);
    softsim_force *answer = calloc(MAX_TICKS + 1, sizeof *answer);
    assert_non_null(out);
    assert_non_null(sent);
    assert_non_null(answer);
    const ss_haptic_config config = {.period = T,
                                     .between_steps = set->between_steps,
                                     .max_force = 8.0,
                                     .max_slew = 2000.0,
                                     .stiffness = set->stiffness,
                                     .damping = set->damping};
    ss_haptic *haptic = ss_haptic_create(&config);
    assert_non_null(haptic);
    device d;
    device_start(&d, set->own, set->script, 1);
    simulation s = {.tissue = {.stiffness = set->tissue}, .period = 1.0 / set->rate_hz};
    ss_haptic_output o = {0};
    ss_simulation_result result;
    bool has_result = false;
    for (int n = 0; n < set->ticks; ++n) {
        run_device(set, n, &d, sent, answer, out);
        /* The server, one way later; its answers are indexed by the pose they answer. */
        const int arrived = n - set->one_way;
        simulate(&s, set, &o.target, n);
        out->peak_reaction = fmax(out->peak_reaction, s.tissue.reaction);
        const bool is_new = take_due(&s, n, &result);
        has_result = has_result || is_new;
        const ss_haptic_input input = {.tick = n + 1,
                                       .pose = arrived >= 0 ? &sent[arrived] : NULL,
                                       .pose_count = arrived >= 0 ? 1 : 0,
                                       .sender_epoch = 1,
                                       .result = has_result ? &result : NULL,
                                       .is_result_new = is_new};
        ss_haptic_tick(haptic, &input, &o);
        if (arrived >= 0) {
            answer[arrived] = o.force;
        }
        out->peak_force = fmax(out->peak_force, o.force.force[2]);
    }
    out->worst_server = o.worst_contact_j;
    out->limit = o.stiffness_limit;
    out->delay_p95_ms = o.loop_delay_ms[1];
    out->hash = ss_haptic_hash(haptic, SS_HASH_START);
    const ss_felt_options options = {.intended_contacts = set->script == TAP ? 4 : 2};
    assert_int_equal(ss_felt_judge(out->row, set->ticks, &options, &out->felt), SOFTSIM_OK);
    ss_haptic_destroy(&haptic);
    free(sent);
    free(answer);
    return out;
}

/* ---- claims ---- */

static setting base(const body *own, script task, double tissue, double rate_hz)
{
    return (setting){.own = own,
                     .script = task,
                     .tissue = tissue,
                     .rate_hz = rate_hz,
                     .lag = 1,
                     .ticks = 2000,
                     .between_steps = SS_BETWEEN_LOCAL,
                     .is_force_seq_known = true,
                     .stiffness = 800.0,
                     .damping = 2.0};
}

static void assert_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance)) {
        print_error("%.17g is not %.17g +- %g\n", value, expected, tolerance);
        fail();
    }
}

/* The simulated hand must be the specified one: 500 N/m, two ticks late, lossless. */
TEST(device_matches_golden_numbers)
{
    static const struct {
        int tick;
        double x, z, vz, f, energy;
    } golden[3] = {
        {300, -8.813059081703534e-06, -1.4828397588406855e-03, -3.9615459047971466e-02, 0.705,
         4.753826449699047e-04},
        {1000, 1.5864715315802944e-02, -2.997519045195684e-03, 3.297218465205668e-03, 1.5,
         2.0919013240455002e-03},
        {1999, 1.9992377072798228e-02, 3.928322825046947e-03, 0.0, 0.0, -2.2328857728669052e-04},
    };
    device d;
    device_start(&d, &bodies[1], PRESS, 1);
    double z[2] = {1.0, 1.0};
    double energy = 0.0;
    for (int n = 0, g = 0; n < 2000; ++n) {
        const double now = quantise(d.x[2]);
        const double f[3] = {0.0, 0.0, fmax(0.0, -500.0 * z[n & 1])};
        z[n & 1] = now;
        const double x = d.x[0], height = d.x[2], speed = d.v[2];
        energy += device_step(&d, f);
        if (n == golden[g].tick) {
            assert_near(x, golden[g].x, 1e-13);
            assert_near(height, golden[g].z, 1e-13);
            assert_near(f[2], golden[g].f, 1e-12);
            assert_near(energy, golden[g].energy, 1e-13);
            if (g < 2) {
                assert_near(speed, golden[g].vz, 1e-12);
            }
            g += g < 2;
        }
    }
}

/* Every hand, every tissue, at a slow and a fast simulation: still, and it gives nothing away. The
 * 4 Hz taps at 0.3 m/s meet the 150 N/m tissue at the resonance of its own mass with a 60 Hz step;
 * that one may hand out what no energy controller is there to take. */
TEST(stays_still_and_passive)
{
    SKIP_WHERE_REPEATED();
    static const double rate_hz[2] = {60.0, 1000.0};
    static const double tissue[5] = {50.0, 150.0, 300.0, 1000.0, 3000.0};
    for (int r = 0; r < 2; ++r) {
        double worst_chatter = 0.0, worst_net = 1.0, worst_tap = 1.0;
        for (int i = 0; i < 3 * 5 * 3; ++i) {
            const script task = (script)(i % 3);
            const setting set = base(&bodies[i / 15], task, tissue[i / 3 % 5], rate_hz[r]);
            outcome *o = run(&set);
            worst_chatter = fmax(worst_chatter, o->felt.chatter_m.value);
            double *worst = task == TAP ? &worst_tap : &worst_net;
            *worst = fmin(*worst, o->felt.net_energy_j.value);
            if (task == PRESS) {
                assert_int_equal(o->felt.chatter_m.verdict, SS_FELT_GOOD);
                assert_int_equal(o->felt.contacts, 1);
            }
            const bool is_resonant = task == TAP && tissue[i / 3 % 5] == 150.0 && r == 0;
            if (o->felt.net_energy_j.verdict != SS_FELT_GOOD && !is_resonant) {
                fail_msg("%g Hz %s %s %g N/m: net %g J", rate_hz[r], set.own->name,
                         script_names[task], set.tissue, o->felt.net_energy_j.value);
            }
            free(o);
        }
        print_message("%g Hz: chatter %.4f mm, net %.3f mJ, taps %.3f mJ\n", rate_hz[r],
                      1e3 * worst_chatter, 1e3 * worst_net, 1e3 * worst_tap);
        assert_true(worst_chatter < 0.035e-3);
        assert_true(worst_net > -0.5e-3);
        assert_true(worst_tap > (r == 0 ? -3e-3 : 0.0));
    }
}

/* The test can fail: the same loop with the last force held is a motor. */
TEST(holding_the_last_force_is_found_bad)
{
    setting set = base(&bodies[0], PRESS, 300.0, 60.0);
    set.between_steps = SS_BETWEEN_HOLD;
    outcome *held = run(&set);
    assert_int_equal(held->felt.net_energy_j.verdict, SS_FELT_BAD);
    set.between_steps = SS_BETWEEN_LINEAR;
    outcome *linear = run(&set);
    assert_int_equal(linear->felt.net_energy_j.verdict, SS_FELT_BAD);
    print_message("hold %.1f mJ, linear %.1f mJ\n", 1e3 * held->felt.net_energy_j.value,
                  1e3 * linear->felt.net_energy_j.value);
    free(held);
    free(linear);
}

/* The limit follows the delay of the loop, as force_seq tells it, and keeps the hand still. */
TEST(limit_follows_the_bus)
{
    static const struct {
        int one_way;
        double delay_ms, limit;
    } row[3] = {{1, 3.0, 571.0}, {2, 5.0, 364.0}, {5, 11.0, 174.0}};
    for (int i = 0; i < 3; ++i) {
        double worst_chatter = 0.0, worst_net = 1.0;
        for (int k = 0; k < 3; ++k) {
            setting set =
                base(&bodies[0], PRESS, (const double[]){300.0, 1000.0, 3000.0}[k], 1000.0);
            set.one_way = row[i].one_way;
            set.ticks = 6000;
            outcome *o = run(&set);
            assert_near(o->delay_p95_ms, row[i].delay_ms, 1e-9);
            assert_near(o->limit, row[i].limit, 1.0);
            worst_chatter = fmax(worst_chatter, o->felt.chatter_m.value);
            worst_net = fmin(worst_net, o->felt.net_energy_j.value);
            assert_int_equal(o->felt.chatter_m.verdict, SS_FELT_GOOD);
            assert_int_equal(o->felt.net_energy_j.verdict, SS_FELT_GOOD);
            /* What the server saw through force_seq is what happened. */
            assert_true(o->worst_server <= fmin(0.0, o->felt.net_energy_j.value) + 0.05e-3);
            free(o);
        }
        print_message("%d ms one way: chatter %.4f mm, net %.3f mJ\n", row[i].one_way,
                      1e3 * worst_chatter, 1e3 * worst_net);
    }
}

/* A client that corrects keeps the stiffness that the bus would cost. */
TEST(correction_keeps_the_stiffness)
{
    setting set = base(&bodies[0], PRESS, 3000.0, 1000.0);
    set.one_way = 1;
    set.corrects = true;
    outcome *o = run(&set);
    print_message("1 ms corrected: limit %.0f N/m, chatter %.4f mm, net %.3f mJ\n", o->limit,
                  1e3 * o->felt.chatter_m.value, 1e3 * o->felt.net_energy_j.value);
    assert_near(o->limit, 800.0, 1e-9);
    assert_int_equal(o->felt.chatter_m.verdict, SS_FELT_GOOD);
    assert_int_equal(o->felt.net_energy_j.verdict, SS_FELT_GOOD);
    free(o);
}

/* Found 10 mm inside 1 kN/m: the hand is not thrown out. */
TEST(device_found_inside_is_let_in_slowly)
{
    for (int b = 0; b < 3; ++b) {
        for (int r = 0; r < 2; ++r) {
            setting set = base(&bodies[b], HOLD_INSIDE, 1000.0, r == 0 ? 60.0 : 1000.0);
            set.ticks = 1500;
            outcome *o = run(&set);
            assert_true(o->peak_hand_speed < 0.15);
            bool has_ramped = false;
            for (int n = 0; n < set.ticks; ++n) {
                has_ramped = has_ramped || (o->row[n].flags & SOFTSIM_FORCE_RAMPING);
            }
            assert_true(has_ramped);
            assert_false(o->row[set.ticks - 1].flags & SOFTSIM_FORCE_RAMPING);
            assert_true(o->row[set.ticks - 1].f[2] > 0.5);
            free(o);
        }
    }
}

TEST(equal_runs_give_equal_bits)
{
    const setting set = base(&bodies[1], POKE, 300.0, 60.0);
    outcome *a = run(&set);
    outcome *b = run(&set);
    assert_true(a->hash == b->hash);
    assert_memory_equal(a->row, b->row, sizeof a->row);
    setting other = set;
    other.tissue = 301.0;
    outcome *c = run(&other);
    assert_true(c->hash != a->hash);
    SS_EACH(free, a, b, c);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
