/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/cnn/cnn.h"
/*
 * Strained tissue that springs back under a tool, and gains nothing from it.
 *
 * psi_0 (source.c) rises to psi for next to nothing while a tool barely touches tissue that is
 * strained already. With the tool pressed in, a near 1, the source pulls that tissue back with all
 * its force; psi falls, psi_0 with it, and what the source did is a dpsi_0 from nowhere. Booked as
 * the tool's work, a tool that shakes by 1 mm in a kidney fed the motion 3 J a millisecond: tissue
 * that is flung off is strained the more where it is met the next time.
 *
 * So what a fall of psi_0 gave is taken out of the motion again: at once along the force of the
 * sources, which is what a source without force in that direction would have done; the rest, which
 * went on into other energies, is owed and damps all motion with a time constant of 10 ms (at once
 * where it is more than a touch gives), until it is paid or the body has lost it otherwise. Where
 * tissue comes to rest is the same as before: a body that does not move pays nothing.
 *
 * Rejected: forces only for strain beyond that of the first touch (the equilibrium of a pressed
 * tool then depends on its way there), no source while psi is below psi_0 (the same, and chatter at
 * the kink), limits of speed or displacement (neither is large before the energy is).
 */
#include <math.h>
#include <string.h>

/* s, of what is owed. */
#define PAY_TIME 0.01
/* Of the energy that no hand feels: more, about what a hand gives in a touch, is not owed for long.
 */
#define MOST_OWED 1e3

/* Forces of the tools' sources, through strain and weights, into model->us. */
static void add_up_sources(ss_model *model)
{
    const ss_cnn_part *part = model->part;
    for (int32_t s = 0; s < part->count; ++s) {
        const ptrdiff_t end = 4 * (ptrdiff_t)part->span[s].node_end;
        for (ptrdiff_t at = 4 * (ptrdiff_t)part->span[s].node; at < end; ++at) {
            model->us[at] = model->base[at] - model->load_force[at];
        }
    }
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        const ss_cnn_source *source = &model->tool[k].source;
        if (source->is_on) {
            const ss_real *b = model->is_held ? source->b : source->b_turned;
            model->kernels->axpy(part, -source->c1, source->r, model->us);
            model->kernels->axpy(part, source->c2, b, model->us);
        }
    }
}

static void take(ss_model *model, double energy)
{
    model->kinetic -= energy;
    model->work -= energy;
    model->damped += energy;
}

/* Takes up to `most` J out of the motion along the sources' forces, as far as it goes with them;
 * returns what it took. */
static double slow_along_sources(ss_model *model, double most)
{
    const ss_cnn_part *part = model->part;
    double power = 0.0, square = 0.0;
    add_up_sources(model);
    for (int32_t s = 0; s < part->count; ++s) {
        const ptrdiff_t end = 4 * (ptrdiff_t)part->span[s].node_end;
        for (ptrdiff_t at = 4 * (ptrdiff_t)part->span[s].node; at < end; ++at) {
            const double force = model->mobility[at] > 0 ? (double)model->us[at] : 0.0;
            power += force * (double)model->v[at];
            square += force * force * (double)model->mobility[at];
        }
    }
    if (!(power > 0.0 && square > 0.0)) {
        return 0.0;
    }
    const double taken = fmin(most, 0.5 * power * power / square);
    const double left = fmax(0.0, power * power - 2.0 * square * taken);
    const double share = (power - sqrt(left)) / square;
    for (int32_t s = 0; s < part->count; ++s) {
        const ptrdiff_t end = 4 * (ptrdiff_t)part->span[s].node_end;
        for (ptrdiff_t at = 4 * (ptrdiff_t)part->span[s].node; at < end; ++at) {
            model->v[at] -= (ss_real)(share * (double)model->mobility[at] * (double)model->us[at]);
        }
    }
    take(model, taken);
    return taken;
}

/* Damps all motion for what is owed. */
static void pay(ss_model *model, double h)
{
    const double in_time = fmin(model->owed, -expm1(-h / PAY_TIME) * model->kinetic);
    const double at_once = model->owed - MOST_OWED * model->small_energy;
    const double taken = fmin(model->kinetic, fmax(in_time, at_once));
    const double factor = model->kinetic > 0.0 ? sqrt(1.0 - taken / model->kinetic) : 1.0;
    for (ptrdiff_t at = 0; at < 4 * (ptrdiff_t)model->node_count; ++at) {
        model->v[at] *= (ss_real)factor;
    }
    ss_cnn_active_set_damp(model, factor);
    take(model, taken);
    model->owed -= taken;
}

void ss_cnn_spring_settle(ss_model *model, double h)
{
    double given = 0.0;
    for (int k = 0; k < SOFTSIM_MAX_PROBES; ++k) {
        given += model->tool[k].source.given;
        model->tool[k].source.given = 0.0;
    }
    if (given > 0.0) {
        const double taken = slow_along_sources(model, given);
        model->owed += given - taken;
    }
    if (model->owed > 0.0) {
        pay(model, h);
        model->owed = fmin(model->owed, model->kinetic + model->elastic);
    }
}
