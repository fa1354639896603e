/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Generated bodies of tetrahedra with their groups of nodes, and their surfaces alone.
 *
 *   kidney, liver, ellipsoid   level sets (shape.h) by stuffing.h, coarser inside; "fixed"
 *                              (kidney: at the hilum, liver: at the bare area)
 *   cylinder                   about z, rings times layers; "bottom", "top", "side"
 *   ventricle                  between two ellipsoids about z, cut at z = base: "endo", "epi",
 *                              "base"; the apex is below
 *   ellipsoids                 between two concentric ellipsoids; "inner", "outer"
 *   block, beam                boxes of cubes, each cut in five; "left" "right" (x), "front"
 *                              "back" (y), "bottom" "top" (z); beam: "fixed" (least x), "free"
 */
#include <stdbool.h>

#include "mesh/mesh.h"

typedef enum volume_kind {
    VOLUME_KIDNEY,
    VOLUME_LIVER,
    VOLUME_ELLIPSOID,
    VOLUME_CYLINDER,
    VOLUME_VENTRICLE,
    VOLUME_ELLIPSOIDS,
    VOLUME_BLOCK,
    VOLUME_BEAM
} volume_kind;

typedef struct volume_plan {
    volume_kind kind;
    double size[3];  /* m, extents along x, y, z; not of kidney and liver */
    double inner[3]; /* m, extents of the inner ellipsoid */
    double base;     /* m, ventricle: height of the base above the centre */
    int32_t points;  /* about that many nodes; of the surface where is_surface */
    bool is_surface; /* only its surface is wanted (not of level sets): boxes come without inside */
} volume_plan;

enum { VOLUME_MIN_POINTS = 64, VOLUME_MAX_POINTS = 2000000 };

softsim_status volume_create(const volume_plan *plan, ss_mesh **out, softsim_error *error);

/* The groups "fixed" of the organs, for surfaces from spread.h. */
bool volume_add_groups(const volume_plan *plan, ss_mesh *mesh);
/* The names of the groups, "left, right"; "" where there are none. */
void volume_name_groups(volume_kind kind, char *out, size_t size);

/* The surface of `volume` with its groups, numbers closed up. NULL when out of memory. */
ss_mesh *volume_take_surface(const ss_mesh *volume);
