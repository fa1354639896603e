/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "world/omission.h"

#include <stdio.h>
#include <string.h>

typedef struct omission_list {
    ss_omission *omission;
    int32_t count;
} omission_list;

static void take(void *sink, const ss_note *note)
{
    omission_list *list = sink;
    if (note->kind != SS_NOTE_LEFT_OUT || list->count == SS_MAX_OMISSIONS) {
        return;
    }
    ss_omission *out = &list->omission[list->count++];
    *out = (ss_omission){.value_count = 0};
    (void)snprintf(out->name, sizeof out->name, "%s", note->where);
    (void)snprintf(out->reason, sizeof out->reason, "%s", note->text);
    const char *at = note->put_back != NULL ? note->put_back : "";
    while (*at != '\0' && out->value_count < SS_OMISSION_VALUES) {
        const int length = (int)strcspn(at, ";");
        (void)snprintf(out->value[out->value_count++], SS_OMISSION_TEXT, "%.*s", length, at);
        at += length + (at[length] == ';');
    }
}

int32_t ss_world_omissions(const ss_world *world, ss_omission out[SS_MAX_OMISSIONS])
{
    omission_list list = {out, 0};
    const ss_notes notes = {take, &list};
    ss_world_explain(world, &notes);
    return list.count;
}

softsim_status ss_omissions_of_scene(const char *scene, const softsim_config *config,
                                     ss_omission out[SS_MAX_OMISSIONS], int32_t *out_count,
                                     softsim_error *error)
{
    softsim_world *world = softsim_create(scene, config, error);
    if (world == NULL) {
        return error->status;
    }
    *out_count = ss_world_omissions(ss_world_of(world), out);
    softsim_destroy(&world);
    return SOFTSIM_OK;
}

const ss_omission *ss_omission_find(const ss_omission *omission, int32_t count, const char *name,
                                    softsim_error *error)
{
    char others[512] = "";
    size_t size = 0;
    const ss_omission *found = NULL;
    for (int32_t i = 0; i < count; ++i) {
        found = strcmp(omission[i].name, name) == 0 ? &omission[i] : found;
        if (omission[i].value_count > 0 && size < sizeof others) {
            size += (size_t)snprintf(others + size, sizeof others - size, "%s'%s'",
                                     size > 0 ? ", " : "", omission[i].name);
        }
    }
    if (found != NULL && found->value_count > 0) {
        return found;
    }
    softsim_error_add(error, SOFTSIM_ERROR_ARGUMENT,
                      "--force-include '%s': %s; this scene's plan has what can be: %s", name,
                      found != NULL ? "no values put it back with the same results"
                                    : "nothing of that name is left out",
                      size > 0 ? others : "nothing");
    return NULL;
}
