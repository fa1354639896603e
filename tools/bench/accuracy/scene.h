/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A scene of the user's in place of a reference problem: it becomes a case folder whose reference
 * the program makes itself.
 *
 * The scene's mesh is refined (refine.h) once or twice, and the most accurate model, fem with the
 * scene's own material, is brought to rest on each: fields u0, u1, u2 at the same nodes. With d1 =
 * |u1 - u0| and d2 = |u2 - u1| the ratio r = d1/d2 says how the error falls from mesh to mesh; the
 * reference is u2 + (u2 - u1)/(r - 1), and what it is worth is the size of that correction. With
 * one refinement r is taken as 2, the least that a field with a load's edge in it shows. At rest
 * the step no longer matters: what would change with it is gone. Of the least settled run a share e
 * of the field is missing, which both fields of the correction may lack: (r + 1)/(r - 1) e is added
 * to what the reference is worth. A run that ends degraded makes none.
 *
 * What a case can say is what a scene may have: nodes fixed along all axes, one prescribed set that
 * moves along one direction, or a pressure, or gravity. Forces on single nodes have no limit as the
 * mesh is refined, tools no path here: scenes with the one are refused, the other is left out.
 * Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "case/case.h"
#include "softsim/types.h"

typedef struct ss_accuracy_worth {
    int32_t nodes;    /* of the finest mesh */
    double change[2]; /* d1, d2 as fractions of the field; the second NaN with one refinement */
    double ratio;     /* r */
    double unsettled; /* e */
    double left;      /* what the reference is worth: the correction and (r + 1)/(r - 1) e, as
                         fractions of the field */
    char taken[600];  /* what of the scene is used and what is not */
    char text[1200];  /* what the reference is worth, in words */
} ss_accuracy_worth;

/* Its name and levels, of every material that it may have; nothing is read. */
void ss_accuracy_scene_outline(ss_case *out);

/* Makes `folder`, there already or not, a case folder; tells on stderr what of the scene is used.
 * Scenes that cannot be one are refused with SOFTSIM_ERROR_SCENE or what the scene loader says. */
softsim_status ss_accuracy_scene(const char *scene, const char *folder, bool is_quick,
                                 ss_accuracy_worth *out, softsim_error *error);
