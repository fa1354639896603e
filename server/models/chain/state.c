/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/chain.h"
/*
 * What every file of the chain does to its state: says a verdict, and wakes what a node that has
 * moved is linked to.
 */

void ss_chain_tell(ss_model *model, softsim_verdict verdict, const char *reason)
{
    if (verdict > model->verdict) {
        model->verdict = verdict;
        model->reason = reason;
    }
}

void ss_chain_wake(ss_model *model, int32_t node)
{
    for (int32_t k = model->net->first[node]; k < model->net->first[node + 1]; ++k) {
        ss_chain_set_add(&model->front.awake, model->net->at[k] / SS_CHAIN_LANES);
    }
}
