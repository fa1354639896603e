/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The world: all state, and the pieces of work that the loops call. Nothing here owns a thread in
 * real time; loops/loops.c gives each piece its thread. In lockstep and headless runs one thread
 * calls all of them, with an optional worker that computes the next simulation step meanwhile.
 *
 * Time. A tick is one haptic period T; a simulation step is `step_ticks` = m of them, h = m T. The
 * step that starts at tick n runs to the proxies of tick n and its result reaches the haptic loop
 * at tick n + m: exactly one simulation period late in lockstep, about that in real time.
 *
 *   poses -> [ring] -> haptic tick -> [mailbox: proxy target] -> simulation step
 *                          ^ [mailbox: local model] <--------------'   '--> [mailbox: surface]
 *                          '--> [ring: forces]
 */
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "contact/contact.h"
#include "haptic/haptic.h"
#include "models/model.h"
#include "models/sleep.h"
#include "net/net.h"
#include "rt/histogram.h"
#include "rt/mailbox.h"
#include "rt/ring.h"
#include "scene/scene.h"
#include "softsim/config.h"
#include "softsim/softsim.h"
#include "world/drawn.h"
#include "world/watch.h"

/* A command on its way to a loop. */
typedef struct ss_command_record {
    ss_command_kind kind;
    ss_scene_live_key key; /* SS_COMMAND_SET */
    int32_t row;           /* of the model's table, for SS_LIVE_MODEL_ROW */
    double value;
} ss_command_record;

/* What a command `set` has set a key to. */
typedef struct ss_set_value {
    bool is_set;
    double value;
} ss_set_value;

/* What the haptic loop reports, every tick. */
typedef struct ss_haptic_stats {
    double lateness_us[4]; /* p50, p99, p99.9, max; 4 times a second */
    int64_t superseded;
    int64_t late_periods;
    double worst_contact_j[SOFTSIM_MAX_PROBES];
    double stiffness_limit[SOFTSIM_MAX_PROBES];
    int64_t stiffness_backoffs; /* of all probes, so far */
    double loop_delay_ms[2];
    double energy_to_device_j, energy_from_device_j;
    ss_hand_verdict hand; /* of energy that any hand was given lately: watch.h */
} ss_haptic_stats;

/* What the simulation reports, after each step. */
typedef struct ss_simulation_stats {
    ss_model_info info;
    double step_us[3]; /* p50, p99, max */
    double lag;        /* share of real time that is not simulated; 0 in lockstep */
    bool is_paused;
} ss_simulation_stats;

/* A surface snapshot for the publisher: `number` has a displacement of 3 floats a drawn node and,
 * of a model with a potential, what acts in it, one a node, while publish.field asks for it. */
typedef struct ss_surface_snapshot {
    int64_t step;
    bool has_source;
    float number[];
} ss_surface_snapshot;

/* One probe: its tool in the world. */
typedef struct ss_world_probe {
    bool is_used;
    ss_haptic *haptic;  /* haptic thread */
    ss_hand_watch hand; /* haptic thread */
    double taken_j;     /* J, from its device so far; haptic thread */
    ss_ring *poses;     /* net -> haptic */
    ss_mailbox *result; /* simulation -> haptic: ss_simulation_result */
    ss_mailbox *target; /* haptic -> simulation: ss_proxy_target */
    /* simulation thread */
    ss_tool_pose last; /* p-hat of the last step */
    bool was_present;
    uint32_t last_teleports;
    int64_t steps_unplaced; /* steps on end: inside the tissue, and no free place found for it */
    int64_t next_search; /* of them: a place is looked for again; 0: none was looked for in vain */
    ss_contact_exit search;        /* begun: the look for a place goes on */
    double depth;                  /* m, how deep it stood there lately */
    bool is_found_inside;          /* it stands where it just touches, until it is entered */
    uint32_t found_entries;        /* of the target then */
    double outward[3];             /* the way there */
    double inward[3];              /* unit: how it was last pressed into the tissue; 0 not known, */
    uint32_t inward_restart_count; /* after which start, */
    uint32_t inward_holders;       /* and by which device */
    bool is_pressed_in;            /* it was, when it was last in the world */
    ss_proxy_target step_target;   /* target of the step under way */
    ss_simulation_result computed; /* result of that step, until it is due */
    /* lockstep: the answer to the newest pose, for repeated ones */
    int32_t answered_seq;
    int64_t answered_sender;
    uint64_t answered_source;
    bool has_answer;
    softsim_force answer;
    int64_t last_good_tick;
} ss_world_probe;

/* What a loop has heard of pauses, resumes and resets. */
typedef struct ss_loop_run {
    bool is_paused;
    uint32_t restart_count; /* resets and resumes */
} ss_loop_run;

static inline void ss_loop_hear(ss_loop_run *run, ss_command_kind kind)
{
    run->is_paused = kind == SS_COMMAND_PAUSE || (run->is_paused && kind != SS_COMMAND_RESUME);
    run->restart_count += kind == SS_COMMAND_RESUME || kind == SS_COMMAND_RESET;
}

typedef struct ss_world {
    ss_scene *scene;
    const ss_model_class *model_class;
    ss_model *model; /* simulation thread */
    ss_sleep *sleep; /* simulation thread; NULL: simulation.sleep is off */
    ss_gate *gate;   /* net thread */
    ss_haptic_config haptic_config;
    ss_world_probe probe[SOFTSIM_MAX_PROBES];
    uint8_t used_probes;
    int32_t threads;
    bool has_budget;          /* of sub-steps, by simulation.max_substeps */
    double period;            /* s, T */
    int32_t step_ticks;       /* m */
    double step_period;       /* s, h = m T */
    double step_cost_us;      /* estimated */
    double yardstick;         /* what a step took here over that, rate.c; 0: not looked at */
    double planned_yardstick; /* that, where the model plans by it; 0: it plans by counts */
    uint64_t plan_hash;
    ss_prescribed *prescribed;
    ss_drawn drawn;              /* the surface that is published */
    int32_t *node_of_file;       /* our number of each node of the file; NULL: the same */
    int32_t (*file_triangle)[3]; /* the surface in the file's numbers; NULL: the mesh's */

    ss_ring *forces;              /* haptic -> net: ss_force_record */
    ss_ring *haptic_commands;     /* net -> haptic: ss_command_record */
    ss_ring *simulation_commands; /* net -> simulation */
    ss_mailbox *haptic_stats;     /* haptic -> net */
    ss_mailbox *simulation_stats; /* simulation -> net */
    ss_mailbox *surface;          /* simulation -> publish: ss_surface_snapshot; NULL without */
    atomic_int field;             /* net -> simulation, publish: ss_scene_field */

    ss_set_value *set_value; /* net thread; the model's rows from SS_LIVE_MODEL_ROW on */

    /* haptic thread */
    ss_histogram *lateness;
    double lateness_us[4]; /* p50, p99, p99.9, max, renewed 4 times a second */
    int64_t next_quantiles_tick;
    int64_t superseded, late_periods;
    double taken_j; /* J, from all devices up to the last tick */
    ss_loop_run haptic_run;
    bool is_answering;                /* a probe has had its first pose */
    bool has_target;                  /* a tool is in the world, by the last targets */
    ss_hand_verdict hand, worst_hand; /* lately; ever. Read by the lockstep thread too */
    atomic_bool is_stopping;          /* any -> haptic */

    /* simulation thread */
    ss_histogram *step_time;
    int64_t steps;
    int64_t substeps; /* of all steps */
    ss_loop_run simulation_run;
    int64_t deformed_until; /* step: before it, tissue that a tool held off may spring back */
    bool is_hashed;         /* `hash` is that of the state as it is; lockstep */
    uint64_t hash;
    double lag; /* as in the stats */
    ss_energy_watch energy;
    bool has_new_surface;   /* since the last snapshot */
    int shown_field;        /* in it: ss_scene_field */
    int32_t snapshot_every; /* periods between surface snapshots; 0: no publisher */
    int64_t periods;        /* so far, those of a pause too: what a command changes then is shown */
    double step_quantiles[3];
    softsim_verdict worst_verdict; /* of any step so far */
    const char *worst_reason;      /* of the first step with it; NULL while good */

    /* lockstep and headless */
    int64_t tick;
    bool is_step_pending; /* a step was begun and its result is not yet posted */
    struct ss_step_worker *worker;
} ss_world;

#define SS_YARDSTICK_MEASURED (-1.0)

typedef struct ss_world_options {
    const char *scene_path;
    const char *const *set;
    int32_t set_count;
    int32_t threads;
    double step_s; /* 0: the scene's rates */
    bool is_lockstep;
    double yardstick; /* real time, a rate that the scene leaves open: scales the counted cost; 0:
                       * not, SS_YARDSTICK_MEASURED: by steps that are timed */
    bool has_budget;  /* max_substeps limits a step; without a clock to meet nothing but a bound on
                       * the loop does */
    const char *import_program;
} ss_world_options;

/* Loads, plans, allocates everything; leaves the calling thread without denormals. Thread: set-up
 * only. */
softsim_status ss_world_create(const ss_world_options *options, ss_world **out_world,
                               softsim_error *error);
void ss_world_destroy(ss_world **world);

/* The world behind the public handle, for programs of this tree that look deeper. Thread: any. */
ss_world *ss_world_of(softsim_world *world);
/* What the model is planned from, all but its step. Thread: set-up only. */
ss_model_plan ss_world_plan(const ss_world *world);
/* The plan, a note per fact: what the scene uses, what is left out, what the model doubts, bytes,
 * threads. Thread: set-up only. */
void ss_world_explain(const ss_world *world, const ss_notes *out);
/* The same with its figures and every doubt as one object of JSON, for programs. */
void ss_world_explain_json(const ss_world *world, FILE *out);
/* Fills in node_of_file and file_triangle. Thread: set-up only. */
softsim_status ss_world_plan_numbers(ss_world *world);
/* What `object.repair` mended, and what a valid scene may still have wrong: sizes that hardly
 * anyone means; and what the model's plan warns of. A warning each. Thread: set-up only. */
void ss_world_doubt(const ss_world *world, const ss_notes *out);
/* What the author of a new scene asks first: the body's box, how much is held, which values of
 * regions overlap, what a step costs, and how a hand gets to the tissue. Notes of what is used.
 * Thread: set-up only. */
void ss_world_advise(const ss_world *world, const ss_notes *out);
/* Descriptors of the models built in, for scene/. Returns their number. */
int32_t ss_world_scene_models(ss_scene_model out_models[SS_MAX_MODELS]);

/* One haptic tick of every used probe. `due_ns` (0 in lockstep) and `now_ns`: when the period was
 * due and when it began. Thread: haptic; RT-safe. */
void ss_world_haptic_tick(ss_world *world, int64_t tick, int64_t due_ns, int64_t now_ns);

/* The model's own account, and what the world adds: a tool that has sunk far into the tissue is a
 * guarded verdict, and so is energy that no hand can have put there (watch.h). Thread: simulation;
 * RT-safe. */
void ss_world_info(const ss_world *world, ss_model_info *out_info);

/* The watch over the tissue's energy, with the scene's limits. Thread: set-up only. */
void ss_world_plan_watch(ss_world *world);
/* A tool that sinks into the tissue, or is through its surface. Thread: simulation; RT-safe. */
void ss_world_judge_sinking(const ss_world *world, ss_model_info *info);

/* Begins a step (takes the proxy targets), computes it, posts its results. In real time the three
 * run one after the other; in lockstep the results are posted one period later.
 * Thread: simulation (begin and post may run on the lockstep thread while no compute runs);
 * RT-safe. */
void ss_world_step_begin(ss_world *world);
void ss_world_step_compute(ss_world *world);
void ss_world_step_post(ss_world *world);

/* While the model sleeps and no tool is in the world: how many steps from now on nothing can happen
 * in but by a command or a tool; else 0. Thread: simulation; RT-safe. */
int64_t ss_world_idle_steps(const ss_world *world);
/* They went by. Thread: simulation; RT-safe. */
void ss_world_skip_steps(ss_world *world, int64_t count);
/* Is any tool in the world by the newest proxy targets? Thread: simulation; RT-safe. */
bool ss_world_has_tool(const ss_world *world);

/* Lockstep: judges the poses and moves the world by one tick; out_force as softsim_tick. */
softsim_refusal ss_world_lockstep(ss_world *world, const softsim_pose *pose, const int32_t *channel,
                                  int32_t count, softsim_force out_force[SOFTSIM_MAX_PROBES]);
/* Waits until the step under way is computed (its results may still be held back). */
void ss_world_settle(ss_world *world);
/* Of the state; recomputed only when a step or a command has changed it. */
uint64_t ss_world_hash(ss_world *world);
/* The surface as it is published; borrowed from the world. Thread: any. */
ss_publish_mesh ss_world_publish_mesh(const ss_world *world);
/* Ends the lockstep worker, if any; call it before ss_world_destroy. Thread: set-up only. */
void ss_lockstep_stop(ss_world *world);

/* Live key number 0, 1, ... as it is set now, "PATH=VALUE LOW HIGH UNIT" with HIGH the most that a
 * command may set; false beyond the last. Thread: net. */
bool ss_world_describe_live(const ss_world *world, int32_t number, char *out, size_t size);

/* Takes a command (net thread): what concerns the loops is handed to them; what concerns the
 * caller (REFRESH, STATUS, SHUTDOWN, and SET of the publisher's values) is told by *out_record.
 * Fills `out_text` and returns the reply's code: 0 done, 1 refused, 2 unknown or bad. */
int32_t ss_world_command(ss_world *world, const char *name, const char *argument,
                         ss_command_record *out_record, char *out_text, int32_t text_size);
