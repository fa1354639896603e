/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Pictures of deformed surfaces: faces in light and shade from one or more sides, side by side,
 * with the outline of the body at rest drawn over them. Projection, shading and the order of faces
 * from far to near are computed here, so that gnuplot only fills polygons and every version of it
 * draws the same. Thread: main.
 */
#include <stdint.h>

#include "bench/papers/paper.h"

typedef struct ss_surface_picture {
    int32_t node_count, face_count;
    const double (*rest)[3]; /* m */
    const double (*u)[3];
    const int32_t (*face)[4]; /* the last -1 in a triangle */
    const uint32_t *colour;   /* 0xRRGGBB of a face; NULL: one for all */
    int32_t ring_count;       /* a closed line of the body at rest beside its outline; 0: none */
    const int32_t *ring;
    int32_t mark_count; /* nodes with a dot */
    const int32_t *mark;
    int32_t pushed;              /* node that an arrow points at, -1 none */
    double push[3];              /* the arrow's direction */
    double ball_radius, ball[3]; /* a tool; radius 0: none */
} ss_surface_picture;

typedef struct ss_surface_picture_view {
    double eye[3], up[3]; /* directions, the first towards who looks */
    const char *label;
} ss_surface_picture_view;

/* Triangles as faces, or NULL without memory; freed by the caller. */
int32_t (*ss_surface_faces(int32_t triangle_count, const int32_t (*triangle)[3]))[4];
/* Draws `name`.png into the page. */
softsim_status ss_surface_picture_put(ss_page *page, const char *name, const char *caption,
                                      const ss_surface_picture *shape,
                                      const ss_surface_picture_view *view, int32_t view_count,
                                      softsim_error *error);
/* The same into a paper's page. */
softsim_status ss_surface_picture_draw(ss_paper *paper, const char *name, const char *caption,
                                       const ss_surface_picture *shape,
                                       const ss_surface_picture_view *view, int32_t view_count,
                                       softsim_error *error);
