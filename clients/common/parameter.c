/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "parameter.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Number `place` of "path=VALUE LEAST MOST UNIT". */
static double number_of(const softsim_scene_report *scene, const char *path, int32_t place)
{
    const size_t length = strlen(path);
    for (int32_t i = 0; i < scene->parameter_count; ++i) {
        const char *text = scene->parameter[i];
        if (strncmp(text, path, length) == 0 && text[length] == '=') {
            const char *at = text + length + 1;
            double value = 0.0;
            for (int32_t k = 0; k <= place; ++k) {
                char *end = NULL;
                value = strtod(at, &end);
                at = end;
            }
            return isfinite(value) && value > 0.0 ? value : 0.0;
        }
    }
    return 0.0;
}

double ss_parameter_of(const softsim_scene_report *scene, const char *path)
{
    return number_of(scene, path, 0);
}

double ss_parameter_most(const softsim_scene_report *scene, const char *path)
{
    return number_of(scene, path, 2);
}
