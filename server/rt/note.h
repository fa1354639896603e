/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * What a plan says of itself, fact by fact: what a scene uses, what is left out, and what is
 * doubtful. A model hands its notes to a sink; who looks for one compares `kind` and `where`, and
 * nobody reads `text` but people. Thread: set-up only.
 */
#include <stddef.h>

typedef enum ss_note_kind { SS_NOTE_USED, SS_NOTE_LEFT_OUT, SS_NOTE_WARNING } ss_note_kind;

typedef struct ss_note {
    ss_note_kind kind;
    /* A part of the plan ("solver"); of a warning the key of the scene that it is about
     * ("object.fixed"). */
    const char *where;
    const char *text; /* one line, without control characters; of what is left out: why */
    /* Of what is left out: the values of the scene, PATH=VALUE parted by ';', with which the plan
     * has it all the same and every result is what it is without; NULL: no values do that. */
    const char *put_back;
} ss_note;

/* Where they go. A note is valid during the call. */
typedef struct ss_notes {
    void (*take)(void *sink, const ss_note *note);
    void *sink;
} ss_notes;

/* Notes of one kind each; what is beyond SS_LINE_SIZE is cut off. */
void ss_note_used(const ss_notes *to, const char *where, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void ss_note_left_out(const ss_notes *to, const char *where, const char *put_back,
                      const char *format, ...) __attribute__((format(printf, 4, 5)));
void ss_note_warning(const ss_notes *to, const char *where, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* A note as people read it: "solver: ...", "left out: friction (...)", "warning: loads: ...". */
void ss_note_print(const ss_note *note, char *out, size_t size);
