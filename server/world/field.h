/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A scalar per node to colour a body by, computed from what is published anyway: the displacements;
 * and the model's own potential, of which a step tells what acts while somebody wants to see it.
 *
 *   displacement  |u|, m
 *   energy        W(F), J/m^3: what the scene's law stores where the body is as it is published
 *   pressure      -tr(sigma) / 3, Pa, sigma = P F^T / J: positive where tissue is squeezed
 *   potential     J, the model's own: of the cells of cnn-energy
 *
 * F is each tetrahedron's own; a node has the mean of its tetrahedra, weighted by rest volume. For
 * energy and pressure no model has to tell anything, the simulation thread has nothing to do for
 * it, and every model that takes moduli is coloured by the same law: of corotational and of
 * springs, whose energies are other ones, it is what tissue of these moduli would store, St.
 * Venant-Kirchhoff where their law is none of the list. Rejected: energies told by each model's
 * kernels (they have none per node, and would pay for it in every step). Memory: by
 * ss_field_create, when a field is first wanted. Thread: one that may allocate.
 */
#include "models/model.h"
#include "scene/scene.h"
#include "world/drawn.h"

typedef struct ss_field ss_field;

/* Can the scene's body be coloured by it? Thread: any. */
bool ss_field_is_possible(const ss_scene *scene, const ss_model_class *model, ss_scene_field kind);
/* What a body lacks that it is not possible for. */
const char *ss_field_lack(ss_scene_field kind);
/* Those that are possible, with `between` them. */
void ss_field_list(const ss_scene *scene, const ss_model_class *model, const char *between,
                   char *out, size_t size);
/* `drawn` outlives it. NULL without memory. */
ss_field *ss_field_create(const ss_scene *scene, const ss_model_class *model,
                          const ss_drawn *drawn);
void ss_field_destroy(ss_field **field); /* accepts NULL; nulls */
/* Not of the potential. `displacement`: 3 floats a drawn node; out_value: one a node. Tetrahedra
 * are taken by their corners; nodes in the middle of the surface's sides have the mean of the ends,
 * others of no tetrahedron 0. */
void ss_field_compute(ss_field *field, ss_scene_field kind, const float *displacement,
                      float *out_value);
const char *ss_field_name(ss_scene_field kind);
const char *ss_field_unit(ss_scene_field kind);
