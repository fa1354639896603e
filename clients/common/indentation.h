/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How far a tool has been pushed into the tissue since it first touched it. `depth` of a force is
 * only what is left between the tool and the surface that yields to it (0.4 mm of a press of 10
 * mm), as the virtual coupling's spring and the contact's own stiffness have it. With the tool at
 * x, the proxy at y, which is on the surface at the first touch, and the normal n of each force
 *
 *   indentation = (y - x) . n at the first touch + sum of -(change of x) . n since
 *
 * so that sliding along a curved surface adds nothing. 0 without contact. The sum of the proxy's
 * own way and the depth was rejected: it is 0.37 mm too much at 10 mm, since the proxy stands in
 * the surface too. The distance from the surface at rest was, because a client does not know the
 * body. Thread: one at a time; RT-safe.
 */
#include <stdbool.h>

#include "softsim/types.h"

typedef struct ss_indentation {
    bool is_touching;
    double value;   /* m */
    double last[3]; /* position of the tool at the force before */
} ss_indentation;

/* Takes the next force of one probe and where the tool was in the pose that it answers; returns the
 * indentation in metres. Who only listens gives the force's `proxy`: how far the surface has been
 * pushed in. A position that is not finite counts as the one before. */
double ss_indentation_take(ss_indentation *indentation, const softsim_force *force,
                           const double position[3]);
