/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "net/status_wire.h"

#include <string.h>

/* The encoded message is the type's hash and then the fields, without gaps. */
enum {
    BEFORE = 8 - 1,
#define SCALAR(type, name, line, text) AT_##name, END_##name = AT_##name + (int)sizeof(type) - 1,
#define ARRAY(type, name, count, line, text)                                                       \
    AT_##name, END_##name = AT_##name + (count) * (int)sizeof(type) - 1,
#define TEXT(name, line)
    SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT) AT_TEXTS
#undef SCALAR
#undef ARRAY
#undef TEXT
};
const int64_t ss_status_uptime_at = AT_uptime_s, ss_status_texts_at = AT_TEXTS;

/* Both structs have the same fields of the same types. */
#define SCALAR(type, name, line, text)                                                             \
    _Static_assert(_Generic(((softsim_server_status_t *)0)->name, type : 1, default : 0), #name);
#define ARRAY(type, name, count, line, text)                                                       \
    _Static_assert(sizeof((softsim_server_status_t *)0)->name == (count) * sizeof(type), #name);   \
    _Static_assert(_Generic(*((softsim_server_status_t *)0)->name, type : 1, default : 0), #name);
#define TEXT(name, line)
SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT)
#undef SCALAR
#undef ARRAY
#undef TEXT

#define SCALAR(type, name, line, text)       to->name = from->name;
#define ARRAY(type, name, count, line, text) memcpy(to->name, from->name, sizeof from->name);
#define TEXT(name, line)                     to->name = (char *)(uintptr_t)from->name;
void ss_status_to_wire(const softsim_server_status *from, softsim_server_status_t *to)
{
    SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT)
}

void ss_status_from_wire(const softsim_server_status_t *from, softsim_server_status *to)
{
    SOFTSIM_SERVER_STATUS_LIST(SCALAR, ARRAY, TEXT)
}
