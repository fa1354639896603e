/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "indentation.h"

#include "rt/vec.h"

double ss_indentation_take(ss_indentation *indentation, const softsim_force *force,
                           const double position[3])
{
    if ((force->flags & SOFTSIM_FORCE_CONTACT) == 0) {
        *indentation = (ss_indentation){.is_touching = false};
        return 0.0;
    }
    if (!ss_is_finite(position, 3)) {
        return indentation->value;
    }
    double moved[3];
    ss_sub3(moved, position, indentation->is_touching ? indentation->last : force->proxy);
    indentation->value -= ss_dot3(moved, force->normal);
    indentation->is_touching = true;
    ss_copy3(indentation->last, position);
    return indentation->value;
}
