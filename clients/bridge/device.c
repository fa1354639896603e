/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "device.h"
/* The table of devices: one row a device (device_rows.h, made by CMakeLists.txt). */

#define SS_DEVICE_ROW(object) extern const ss_device_class object;
#include "device_rows.h"
#undef SS_DEVICE_ROW

static const ss_device_class *const table[] = {
#define SS_DEVICE_ROW(object) &object,
#include "device_rows.h"
#undef SS_DEVICE_ROW
};

const ss_device_class *const *ss_device_table(int32_t *out_count)
{
    *out_count = (int32_t)(sizeof table / sizeof *table);
    return table;
}
