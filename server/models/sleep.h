/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Sleep: a model at rest is not stepped.
 *
 * In: each step's contact sets, and where the tools go. Out: whether a step may be left out. A
 * model falls asleep after a second in which nothing acts anew and nothing moves: no load, support
 * or parameter changes, the verdict is good, each node is slower than a hand or an eye can tell,
 * and what is left of its way, and of the change of the force on each tool, is less than that too.
 * While it sleeps its state stays exactly as it is, velocities with it, and the contact sets of its
 * last step go on to be told. It wakes in the step in which a load or a support begins to change, a
 * tool comes, goes, grasps, lets go, or moves or turns by more than matters, and by ss_sleep_wake.
 *
 * A tool in the air moves as it likes: by its distance from the nodes, which is looked up again
 * when it has gone that far.
 *
 * Everything is counted in steps and decided by states, never by a clock, so that a log gives the
 * same bits with any number of threads. It works on what every model tells of itself, and no model
 * knows of it. Rejected: a body's own stillness inside each model, which is one rule nine times;
 * and nodes or regions asleep by themselves, whose borders a force would notice.
 *
 * Thread: create and destroy set-up only; the rest by the simulation thread, RT-safe.
 */
#include "models/model.h"

typedef struct ss_sleep ss_sleep;

/* Of a model that steps by plan->step; what `plan` points to outlives it, but `param`. NULL without
 * memory. */
ss_sleep *ss_sleep_create(const ss_model_class *model_class, ss_model *model,
                          const ss_model_plan *plan);
void ss_sleep_destroy(ss_sleep **sleep);

bool ss_sleep_is_asleep(const ss_sleep *sleep);
/* Something reaches the model that is no tool, load or support. */
void ss_sleep_wake(ss_sleep *sleep);
/* It sleeps through `count` steps, in which nothing can reach it. */
void ss_sleep_skip(ss_sleep *sleep, int64_t count);

/* Before the step from `time` (s) with those tools, of which patches within near[] metres are to be
 * told: does the model sleep through it? */
bool ss_sleep_goes_on(ss_sleep *sleep, double time, const ss_model_tool tool[SOFTSIM_MAX_PROBES],
                      const double near[SOFTSIM_MAX_PROBES]);
/* May tool `probe` of a sleeping model move on without it? Else it stands where it stood. */
bool ss_sleep_is_tool_free(const ss_sleep *sleep, int32_t probe);
/* Had it a tool when it was looked at last? Where that has gone, the model is to hear of it. */
bool ss_sleep_has_tool(const ss_sleep *sleep);
/* Until when (s) nothing changes by itself; INFINITY: for ever. */
double ss_sleep_until(const ss_sleep *sleep);

/* After a step from `time` that was made, what the model then told, and its contact set of each
 * tool that is present. */
void ss_sleep_watch(ss_sleep *sleep, double time, const ss_model_tool tool[SOFTSIM_MAX_PROBES],
                    const double near[SOFTSIM_MAX_PROBES], const ss_model_info *info,
                    const ss_contact_set *const set[SOFTSIM_MAX_PROBES]);
