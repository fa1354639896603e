/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Bodies that are a surface of rings times layers: solid cylinders, shells of ellipsoids. Ring 0
 * is a point; every layer has the same rings, and the prisms between layers are cut in three.
 */
#include "solid.h"

enum { RINGS_MAX = 4096 };

typedef struct rings {
    int32_t ring_count, layer_count; /* 2 or more each */
    int32_t size[RINGS_MAX];         /* nodes of a ring: size[0] = 1; the last may be 1 too */
} rings;

/* Where ring `ring` passes at `angle` (radians) in layer `layer`. */
typedef void (*rings_place)(const void *body, int32_t ring, int32_t layer, double angle,
                            double out[3]);

/* Nodes of a layer. */
int64_t rings_node_count(const rings *r);
/* Node number: layer * rings_node_count + node of the layer, rings in order. False when out of
 * memory. */
bool rings_fill(const rings *r, rings_place place, const void *body, solid *out);
