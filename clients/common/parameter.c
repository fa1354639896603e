/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "parameter.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double ss_parameter_of(const softsim_scene_report *scene, const char *path)
{
    const size_t length = strlen(path);
    for (int32_t i = 0; i < scene->parameter_count; ++i) {
        const char *text = scene->parameter[i];
        if (strncmp(text, path, length) == 0 && text[length] == '=') {
            const double value = strtod(text + length + 1, NULL);
            return isfinite(value) && value > 0.0 ? value : 0.0;
        }
    }
    return 0.0;
}
