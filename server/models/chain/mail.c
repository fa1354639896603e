/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "models/chain/mail.h"
/*
 * How a node of chainmail is moved, and becomes a sponsor: by the law, by tools, by prescribed
 * sets.
 */

/* Fixed and prescribed axes stay. Rounded as it is stored. */
void ss_mail_move_to(ss_model *model, int32_t node, const double u[3])
{
    for (int k = 0; k < 3; ++k) {
        if ((model->bound[node] & (1 << k)) == 0) {
            model->u[4 * (ptrdiff_t)node + k] = (ss_real)u[k];
        }
    }
}

void ss_mail_sponsor(ss_model *model, int32_t node)
{
    if (!model->has_moved[node]) {
        model->has_moved[node] = 1;
        model->queue[model->queue_count++] = node;
    }
}
