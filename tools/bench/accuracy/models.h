/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How the accuracy report makes a case's material of a model's parameters, from the hints in the
 * model's class (models/hints.h). A model without hints is reported as such. Thread: any.
 */
#include <stdbool.h>

#include "case/case.h"
#include "models/model.h"
#include "rt/args.h"

/* Is `name`, of a model or a mesh, in the list "a,b,c"? No list: everything is. */
bool ss_accuracy_is_listed(const char *list, const char *name);
/* NULL: there is no such model, or it has no hints. */
const ss_model_class *ss_accuracy_model_find(const char *name);
/* Has it physical parameters of its own, so that nothing is fitted? */
bool ss_accuracy_model_is_physical(const ss_model_class *model);
/* The model's name of a case's material. */
const char *ss_accuracy_model_material(const ss_model_class *model, const char *material);
ss_hints_body ss_accuracy_body_of(const ss_case *c, const ss_mesh *mesh);
/* The lines under `model:` as a text, to be freed; NULL when out of memory. `set`: KEY=VALUE for
 * models with that parameter; NULL: none. */
char *ss_accuracy_model_text(const ss_model_class *model, const ss_hints_setting *setting,
                             const ss_arg_list *set);
/* May `key`, without what is after its '=', be set: a parameter of a physical model that the case
 * does not give. */
bool ss_accuracy_model_takes(const ss_model_class *model, const char *key);
