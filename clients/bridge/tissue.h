/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Where the tissue is, as the server publishes it: the surface at rest (mesh_topology_t) and the
 * probe's tool (scene_t). For a bridge that is to begin above it, and for one that has missed it.
 * What is displaced at the time is left out: another hand may be pressing. Thread: main, before or
 * after the bridge's own connection.
 */
#include "contact/touch.h"
#include "softsim/client.h"

typedef struct ss_tissue {
    ss_touch_body body; /* its arrays are the tissue's own */
    ss_touch_end end;   /* of the probe's tool */
    const char *tool;   /* "sphere" */
} ss_tissue;

/* One that was started just before may still be loading its scene. */
#define SS_TISSUE_START_S 10.0

/* Asks for both and listens: `start_s` until a server says anything, then some seconds at most.
 * False with why: no server, one without a mesh, without that tool. Of `config` only lcm_url and
 * prefix are read. */
bool ss_tissue_hear(const softsim_client_config *config, int32_t probe, double start_s,
                    ss_tissue *out, softsim_error *error);
void ss_tissue_free(ss_tissue *tissue);
