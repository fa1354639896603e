/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Private to chainmail: its parameters and state, and what its files call of one another.
 * chainmail.c has the law and the class, mail_tools.c the tools, mail.c what both do to a node.
 */
#include "models/chain/net.h"
#include "models/common/inverted.h"
#include "models/common/tools.h"

/* Rows of the model's table. */
enum {
    SS_MAIL_ALPHA,
    SS_MAIL_BETA,
    SS_MAIL_BAND,
    SS_MAIL_ORDER,
    SS_MAIL_RELAXATION_ITERATIONS,
    SS_MAIL_ROW_COUNT
};

/* A neighbour that its sponsor asks to move. */
typedef struct ss_mail_request {
    double violation; /* m */
    int32_t node, sponsor;
} ss_mail_request;

/* What a tool is to the chain, beside what every tool is; its grasp only says which nodes go along
 * with it, and rest_felt is what it feels. */
typedef struct ss_mail_tool {
    ss_tool *base;
    bool is_touching; /* or has just left */
    double e;         /* m, and the rest of the last step's: */
    double dent;      /* m, e - gap: < 0 as it leaves, 0 where it touches nothing */
    double normal[3]; /* n */
    double arm[3];    /* m, from the tool's origin to the line that it is pushed along */
    ss_real *before;  /* u^0: 4 a node */
} ss_mail_tool;

struct ss_model {
    ss_arena arena;
    ss_model_plan plan;
    int32_t node_count;
    bool is_held; /* supports stop every rigid motion */
    ss_chain_net *net;
    double beta;
    bool is_radial, is_by_violation;
    int32_t iterations;
    double *alpha; /* by link position */
    ss_tools tools;
    ss_mail_tool tool[SOFTSIM_MAX_PROBES];
    ss_real *u, *v;     /* v stays 0: there is no motion but that of sponsors */
    uint8_t *has_moved; /* in this propagation */
    int32_t *queue;
    int32_t queue_count;
    ss_mail_request *heap;
    int32_t heap_count;
    ss_real *push; /* scratch of contact */
    double *weight;
    uint8_t *bound; /* axes of a node that are fixed or prescribed: bits 0 to 2 */
    uint8_t *held;  /* by tools, in this step: a bit each */
    int64_t step;
    int64_t fitted_step; /* that the surface was last refitted before; -1 never */
    int32_t moved_count;
    ss_inverted inverted;
    int32_t worst; /* a corner of a tetrahedron inside out, -1 none */
    softsim_verdict verdict;
    const char *reason;
};

/* ---- mail.c ---- */

/* Moves a node; fixed and prescribed axes stay. */
void ss_mail_move_to(ss_model *model, int32_t node, const double u[3]);
/* A node that was moved asks its neighbours in the next propagation. */
void ss_mail_sponsor(ss_model *model, int32_t node);

/* ---- mail_tools.c ---- */

/* Thread: set-up only. */
softsim_status ss_mail_tools_create(ss_model *model, softsim_error *error);
/* One that has touched nothing yet. */
void ss_mail_tool_clear(ss_mail_tool *tool);
/* Takes over where they go; returns the parts of the step in which none goes too far. */
int32_t ss_mail_tools_take(ss_model *model, const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
/* The surface at the end of the step before step number `step`, once, where a tool is present. */
void ss_mail_refit(ss_model *model, int64_t step);
/* The tools at `path` of the step: what they touch becomes a sponsor. */
void ss_mail_tools_move(ss_model *model, double path);
/* Buttons pressed and released. */
void ss_mail_tools_grasp(ss_model *model, const ss_model_tool tool[SOFTSIM_MAX_PROBES]);
/* What they feel at the end of the step. */
void ss_mail_tools_measure(ss_model *model);
void ss_mail_contacts(ss_model *model, int32_t probe, double near, ss_contact_set *out);
