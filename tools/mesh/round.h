/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The true shape of a generated body (volume.h) for the nodes in the middle of its sides.
 */
#include "volume.h"

/* Moves the middles of sides in the smooth surfaces of the body onto them; sides of a box, and of
 * elements that would be bent too far, stay straight. `mesh`: of second order, made by the plan
 * and raised. */
void round_middles(const volume_plan *plan, ss_mesh *mesh);
