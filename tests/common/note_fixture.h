/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* What a model notes of its plan: how many notes of a kind it has about a place. */
#include <string.h>

#include "models/model.h"

typedef struct note_search {
    ss_note_kind kind;
    const char *where;
    const char *part; /* of the text; "": any */
    int count;
} note_search;

static inline void note_take(void *sink, const ss_note *note)
{
    note_search *of = sink;
    of->count += note->kind == of->kind && strcmp(note->where, of->where) == 0 &&
                 strstr(note->text, of->part) != NULL;
}

static inline int note_count(const ss_model_class *class, const ss_model *model, ss_note_kind kind,
                             const char *where, const char *part)
{
    note_search of = {kind, where, part, 0};
    class->explain(model, &(const ss_notes){note_take, &of});
    return of.count;
}
