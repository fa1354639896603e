/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/felt/chain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rt/vec.h"

enum { MASSES = 6, PENDING = 2 };
static const double tissue_mass = 0.030, hardening_m = 0.015, viscous_s = 1e-3;
static const double maxwell_share = 0.4, maxwell_s = 0.1;
/* Contact stiffness over K: a ball of 5 mm dents by a tenth of its radius at its working force. */
static const double contact_ratio = 15.0;
static const double finest_s = 25e-6, probe_m = 10e-6, near_m = 5e-3;
static const double wave_m = 0.5e-3, wave_length_m = 10e-3;

/* Node i sinks by u_i; link i joins node i to i + 1, the last one to the ground. */
typedef struct tissue {
    double stiffness; /* K */
    double u[MASSES], v[MASSES], maxwell[MASSES];
    double reaction;
} tissue;

struct ss_chain {
    ss_chain_config config;
    ss_haptic *haptic;
    int64_t tick;
    ss_haptic_output output;
    /* state: simulation */
    tissue tissue;
    double last[3]; /* where the tool was stepped to */
    bool has_last, was_touching;
    int64_t step;
    uint32_t teleports;
    /* results under way, oldest first, and the tick each is due in */
    ss_simulation_result pending[PENDING], result;
    int64_t due[PENDING];
    int pending_count;
    bool has_result;
};

static double link_force(const tissue *t, double e, double rate, double maxwell)
{
    const double k = MASSES * t->stiffness;
    return k * e * (1.0 + fabs(e) * MASSES / hardening_m) + viscous_s * k * rate + maxwell;
}

/* Sinks the tool from depth `from` to `to` (below the surface at rest) in `h`. */
static void step_tissue(tissue *t, double from, double to, double h)
{
    const int count = (int)ceil(h / finest_s);
    const double dt = h / count;
    const double contact = contact_ratio * t->stiffness;
    for (int s = 1; s <= count; ++s) {
        const double tool = from + (to - from) * s / count;
        double force[MASSES] = {0};
        force[0] = fmax(0.0, contact * (tool - t->u[0]));
        for (int i = 0; i < MASSES; ++i) {
            const bool is_last = i + 1 == MASSES;
            const double rate = t->v[i] - (is_last ? 0.0 : t->v[i + 1]);
            t->maxwell[i] +=
                dt * (maxwell_share * MASSES * t->stiffness * rate - t->maxwell[i] / maxwell_s);
            const double f =
                link_force(t, t->u[i] - (is_last ? 0.0 : t->u[i + 1]), rate, t->maxwell[i]);
            force[i] -= f;
            if (!is_last) {
                force[i + 1] += f;
            }
        }
        for (int i = 0; i < MASSES; ++i) {
            t->v[i] += dt * force[i] * MASSES / tissue_mass;
            t->u[i] += dt * t->v[i];
        }
    }
    t->reaction = fmax(0.0, contact * (to - t->u[0]));
}

/* The tangent at the present reaction, the relaxing branch included (a fast hand meets it), in
 * series with the contact's: K d (1 + d/H) = R. */
static double tangent(const tissue *t)
{
    const double d =
        0.5 * hardening_m * (sqrt(1.0 + 4.0 * t->reaction / (t->stiffness * hardening_m)) - 1.0);
    const double k = t->stiffness * (1.0 + maxwell_share + 2.0 * d / hardening_m);
    return 1.0 / (1.0 / k + 1.0 / (contact_ratio * t->stiffness));
}

/* The surface at rest under `p`: its height, slope and second derivative along x. */
static void surface(const ss_chain *chain, const double p[3], double out[3])
{
    const double w = 2.0 * M_PI / wave_length_m;
    const double height = chain->config.has_waves ? wave_m : 0.0;
    out[0] = height * sin(w * p[0]);
    out[1] = w * height * cos(w * p[0]);
    out[2] = -w * w * out[0];
}

static double depth_of(const ss_chain *chain, const double p[3])
{
    double at[3];
    surface(chain, p, at);
    return at[0] - p[2];
}

/* F = R grad(depth): along the normal n = (-slope, 0, 1) cos, of size R/cos, stiffness k/cos^2. */
static void write_result(ss_chain *chain, const ss_proxy_target *target, const double p[3],
                         double step_tangent, ss_simulation_result *out)
{
    const tissue *t = &chain->tissue;
    const double period = 1.0 / chain->config.rate_hz;
    const double depth = depth_of(chain, p) - t->u[0];
    double at[3];
    surface(chain, p, at);
    const double cosine = 1.0 / sqrt(1.0 + at[1] * at[1]);
    *out = (ss_simulation_result){.tick = target->tick,
                                  .step = chain->step,
                                  .period = period,
                                  .pose_seq = target->pose_seq,
                                  .orientation = {1.0, 0.0, 0.0, 0.0}};
    ss_copy3(out->proxy, p);
    ss_sub3(out->velocity, p, chain->last);
    ss_scale3(out->velocity, out->velocity, 1.0 / period);
    ss_contact_set *set = &out->set;
    const double normal[3] = {-at[1] * cosine, 0.0, cosine};
    const bool touches = t->reaction > 0.0;
    set->depth = depth;
    ss_copy3(set->normal, normal);
    ss_copy3(set->point, p);
    set->point[2] += depth;
    ss_scale3(set->force, normal, t->reaction / cosine);
    if (touches || -depth < near_m + ss_norm3(out->velocity) * 2.0 * period) {
        ss_contact *c = &set->contact[0];
        const double slope = 1.0 / (cosine * cosine);
        set->count = 1;
        ss_copy3(c->point, set->point);
        ss_copy3(c->normal, normal);
        c->force = t->reaction / cosine;
        c->stiffness = slope * tangent(t);
        c->gap = touches ? 0.0 : fmax(1e-12, -depth * cosine);
        c->curvature[0][0] = at[2] * cosine;
        if (touches && chain->was_touching) {
            c->viscosity = fmax(0.0, (slope * step_tangent - c->stiffness) * period);
        }
    }
    chain->was_touching = touches;
}

/* Starts a step when one is due; its result comes a period later. */
static void simulate(ss_chain *chain)
{
    const double period = 1.0 / chain->config.rate_hz;
    const double tick_s = chain->config.haptic.period;
    const ss_proxy_target *target = &chain->output.target;
    if ((double)(chain->tick - 1) * tick_s + 1e-9 < (double)chain->step * period) {
        return;
    }
    ++chain->step;
    if (!target->is_present) {
        step_tissue(&chain->tissue, -1.0, -1.0, period);
        return;
    }
    double p[3];
    ss_haptic_predict(target, 1.0, period, p);
    if (!chain->has_last || target->teleports != chain->teleports) {
        ss_copy3(chain->last, p);
    }
    chain->has_last = true;
    chain->teleports = target->teleports;
    const double from = depth_of(chain, chain->last), to = depth_of(chain, p);
    tissue moved = chain->tissue;
    step_tissue(&moved, from, to + probe_m, period);
    step_tissue(&chain->tissue, from, to, period);
    const double step_tangent = (moved.reaction - chain->tissue.reaction) / probe_m;
    write_result(chain, target, p, step_tangent, &chain->pending[chain->pending_count]);
    chain->due[chain->pending_count++] = chain->tick - 2 + (int64_t)ceil(period / tick_s - 1e-9);
    ss_copy3(chain->last, p);
}

static bool take_due(ss_chain *chain)
{
    bool is_new = false;
    while (chain->pending_count > 0 && chain->due[0] < chain->tick) {
        chain->result = chain->pending[0];
        chain->pending[0] = chain->pending[1];
        chain->due[0] = chain->due[1];
        --chain->pending_count;
        is_new = chain->has_result = true;
    }
    return is_new;
}

ss_chain *ss_chain_create(const ss_chain_config *config)
{
    ss_chain *chain = calloc(1, sizeof *chain);
    if (chain != NULL) {
        chain->config = *config;
        chain->tissue.stiffness = config->tissue_n_per_m;
        chain->haptic = ss_haptic_create(&config->haptic);
    }
    if (chain != NULL && chain->haptic == NULL) {
        ss_chain_destroy(&chain);
    }
    return chain;
}

void ss_chain_destroy(ss_chain **chain)
{
    if (*chain != NULL) {
        ss_haptic_destroy(&(*chain)->haptic);
        free(*chain);
        *chain = NULL;
    }
}

void ss_chain_tick(ss_chain *chain, const softsim_pose *pose, int32_t count,
                   ss_haptic_output *output)
{
    ++chain->tick;
    simulate(chain);
    const bool is_new = take_due(chain);
    const ss_haptic_input input = {.tick = chain->tick,
                                   .pose = pose,
                                   .pose_count = count,
                                   .sender_epoch = 1,
                                   .result = chain->has_result ? &chain->result : NULL,
                                   .is_result_new = is_new};
    ss_haptic_tick(chain->haptic, &input, &chain->output);
    *output = chain->output;
}
