/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bench/papers/hybrid/draw.h"

#include <string.h>

#include "bench/core/surface_picture.h"

softsim_status ss_heart_draw(ss_paper *paper, const char *name, const char *caption,
                             const ss_heart_picture *picture, softsim_error *error)
{
    static const ss_surface_picture_view views[] = {
        {{0.75, 0.6, 0.25}, {0.0, 0.0, 1.0}, "towards the tool"},
        {{0.0, 1.0, 0.1}, {0.0, 0.0, 1.0}, "from the side"}};
    ss_surface_picture shape = {.node_count = picture->node_count,
                                .face_count = picture->face_count,
                                .rest = (const double(*)[3])picture->rest,
                                .u = (const double(*)[3])picture->u,
                                .face = (const int32_t(*)[4])picture->face,
                                .colour = picture->colour,
                                .pushed = -1,
                                .ball_radius = picture->radius};
    memcpy(shape.ball, picture->ball, sizeof shape.ball);
    return ss_surface_picture_draw(paper, name, caption, &shape, views, 2, error);
}
