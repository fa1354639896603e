/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/common/body.h"
/* The class of a model that begins with its body. */

static ss_body *body_of(ss_model *model)
{
    return *(ss_body **)model;
}

static const ss_body *read_body_of(const ss_model *model)
{
    return *(ss_body *const *)model;
}

void ss_body_model_step(ss_model *model, double time, double dt,
                        const ss_model_tool tool[SOFTSIM_MAX_PROBES])
{
    ss_body_step(body_of(model), time, dt, tool);
}

void ss_body_model_contacts(ss_model *model, int32_t probe, double near, ss_contact_set *out)
{
    ss_body_contacts(body_of(model), probe, near, out);
}

void ss_body_model_reset(ss_model *model)
{
    ss_body_reset(body_of(model));
}

void ss_body_model_info(const ss_model *model, ss_model_info *out)
{
    ss_body_info(read_body_of(model), out);
}

const ss_real *ss_body_model_displacement(const ss_model *model)
{
    return ss_body_read_nodes(read_body_of(model))->u;
}

const ss_real *ss_body_model_velocity(const ss_model *model)
{
    return ss_body_read_nodes(read_body_of(model))->v;
}

void ss_body_model_reaction(const ss_model *model, int32_t set, double out_force[3])
{
    ss_body_reaction(read_body_of(model), set, out_force);
}

void ss_body_model_slept(ss_model *model, int64_t steps)
{
    ss_body_slept(body_of(model), steps);
}

uint64_t ss_body_model_hash(const ss_model *model, uint64_t seed)
{
    return ss_body_hash(read_body_of(model), seed);
}
