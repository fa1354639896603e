/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Which tetrahedra are turned inside out, for models that do not know by themselves.
 *
 * Links and springs know lengths: a tetrahedron that is its own mirror image is at rest to them,
 * holds its neighbours wrongly and pulls where it should push. A linear law goes through it without
 * notice. What is published then is no shape that tissue can have, so it is said for as long as it
 * lasts.
 *
 * A step looks at a share of the tetrahedra, in turn, so that a tenth of a second sees them all,
 * and at the last one it found. One that is inside out is said until a whole round has met none:
 * at most a tenth of a second late, either way. Rejected: all in every step, which costs a chain of
 * 20,000 tetrahedra as much as a touch does.
 */
#include "mesh/mesh.h"
#include "rt/real.h"

#define SS_INVERTED_REASON "tetrahedra are turned inside out"

typedef struct ss_inverted {
    const ss_mesh *mesh; /* borrowed; volumes at rest are above 0 */
    int32_t share;       /* tetrahedra a step */
    /* state */
    int32_t at;    /* the next to look at */
    int32_t found; /* the last that was inside out, -1 none in a whole round */
    int32_t clean; /* looked at since one was */
} ss_inverted;

/* For outer steps of `step` s; a mesh without tetrahedra has none inside out. Thread: set-up
 * only. */
void ss_inverted_init(ss_inverted *inverted, const ss_mesh *mesh, double step);
void ss_inverted_reset(ss_inverted *inverted);
/* One step's share at displacements `u` (4 a node of the mesh); a tetrahedron to name, or -1.
 * RT-safe. */
int32_t ss_inverted_look(ss_inverted *inverted, const ss_real *u);
/* Instead of a look, in a step of which something else tells that none is inside out. RT-safe. */
void ss_inverted_pass(ss_inverted *inverted);
/* Of what the steps so far do not tell by their number. */
uint64_t ss_inverted_hash(const ss_inverted *inverted, uint64_t seed);
