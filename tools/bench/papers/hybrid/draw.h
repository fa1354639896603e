/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A deformed body as the pictures of the hybrid report show it. Thread: main. */
#include "bench/papers/paper.h"

typedef struct ss_heart_picture {
    int32_t node_count, face_count;
    double (*rest)[3], (*u)[3]; /* m */
    int32_t (*face)[4];         /* the last -1 */
    uint32_t *colour;           /* 0xRRGGBB */
    double ball[3], radius;     /* radius 0: none */
} ss_heart_picture;

/* Draws `name`.png into the page, towards the tool and from the side. */
softsim_status ss_heart_draw(ss_paper *paper, const char *name, const char *caption,
                             const ss_heart_picture *picture, softsim_error *error);
