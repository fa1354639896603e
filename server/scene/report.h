/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Faults of one scene, gathered and handed out in one go, in the order of the file.
 *
 * In: a place (byte range of the scene's text, or a `--set` option, or another file) and what is
 * wrong there. Out, into softsim_error:
 *
 *     scene.yaml:3:9: error: object.mesh cannot be opened; ...
 *       mesh: kidnee.obj
 *             ^~~~~~~~~~
 *
 * Everything shown is cleaned of control characters first: a scene is a stranger's text, and a
 * terminal obeys escape sequences. Used inside scene/, and by tools that read YAML of their own.
 * Thread: set-up only.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "softsim/types.h"

/* More faults than this are counted, not shown (softsim_error holds fewer than this anyway), and
 * counting ends too: a hostile text can have a million. */
enum { SS_SCENE_MAX_FAULTS = 128, SS_SCENE_MAX_DROPPED = 10000 };

typedef struct ss_scene_fault {
    softsim_status status;
    uint64_t order; /* where it is shown among the others */
    char *text;
} ss_scene_fault;

typedef struct ss_scene_report {
    const char *path;   /* as the user wrote it */
    const char *source; /* the scene's text */
    size_t size;
    const char *const *overrides;
    ss_scene_fault fault[SS_SCENE_MAX_FAULTS];
    int32_t count;
    int32_t dropped; /* faults beyond the array */
} ss_scene_report;

/* A place: bytes offset .. offset + length of the scene, or override number >= 0. */
typedef struct ss_scene_place {
    int32_t override; /* -1: in the file */
    uint32_t offset, length;
} ss_scene_place;

void ss_scene_report_add(ss_scene_report *report, softsim_status status, ss_scene_place place,
                         const char *format, ...) __attribute__((format(printf, 4, 5)));
/* A fault of another file, `line` from 1 (0: the file as a whole), shown after the place in the
 * scene that names it. */
void ss_scene_report_file(ss_scene_report *report, ss_scene_place place, const char *path,
                          int64_t line, const char *format, ...)
    __attribute__((format(printf, 5, 6)));
/* Line number from 1 of a byte of the scene. */
int64_t ss_scene_report_line(const ss_scene_report *report, uint32_t offset);
/* No further fault will be shown. */
bool ss_scene_report_is_full(const ss_scene_report *report);
int32_t ss_scene_report_total(const ss_scene_report *report);
/* Adds every fault to `error` in file order and empties the report. */
void ss_scene_report_flush(ss_scene_report *report, softsim_error *error);
