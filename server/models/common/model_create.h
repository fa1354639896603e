/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * How a model comes to be: what every `create` of ss_model_class does around the model's own part.
 */
#include <stddef.h>

#include "models/model.h"

/* Fills a zeroed model from `plan`; `error` is never NULL. What it leaves behind when it fails is
 * for `destroy`. */
typedef softsim_status (*ss_model_build)(ss_model *model, const ss_model_plan *plan,
                                         softsim_error *error);

/* A model of `size` bytes in *out_model, made by `build`; NULL after a failure, destroyed. `error`
 * may be NULL. Thread: set-up only. */
softsim_status ss_model_make(size_t size, ss_model_build build, void (*destroy)(ss_model *model),
                             const ss_model_plan *plan, ss_model **out_model, softsim_error *error);
