/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The bridge: a device at one end, a server (or a linear tissue, for tests) at the other.
 *
 * Each period T: the newest force comes into effect; the device is read; the force in effect is
 * corrected to where the device is now; the pose goes out, naming that force (`force_seq`) and
 * what was exerted since the pose before (`applied_force`); the device exerts the force until the
 * next period. A still pose is sent like any other.
 *
 * A late period is counted and not made up for: the simulated device then simply stands still
 * meanwhile, which costs realism but never runs two periods on one force.
 * Forces that stay away for a quarter of a second have stopped, and stderr says so; the device's
 * have long faded by then (correct.h). A server that is started again, or another in its place, is
 * taken up, its force as it ramps it in; stderr says so, and the run is not of one body. One whose
 * forces were away for a second, or during which this program was held up as long (suspended), is
 * not all felt.
 * A server that is at fault or paused is waited for; stderr says so once when it begins, and the
 * run is not all felt (halt.h).
 * The force is withheld until who answers has been alone for 40 ms, and while two servers answer
 * (withhold.h). Limits are those of the server whose forces come: another's are forgotten, but for
 * the most that the first one's scene allows, which holds until the bridge ends: who lurks until a
 * server falls silent brings limits of its own.
 * Thread: one, main. Nothing is allocated while it runs but the texts of a status; rows of the CSV
 * go into a large buffer, whose writing out once a second is the one thing that may cost a period.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "bus.h"
#include "correct.h"
#include "device.h"
#include "frame.h"
#include "halt.h"
#include "indentation.h"
#include "output.h"
#include "softsim/client.h"
#include "withhold.h"

typedef struct ss_bridge_config {
    int32_t probe;
    bool is_correcting;
    double damping_n_s_per_m; /* the bridge's own, in contact */
    int64_t tick_count;       /* INT64_MAX: until stopped or the device ends */
    bool is_endless;          /* only a signal ends it, which is then its end */
    ss_bus_config bus;        /* both directions; zeroes: none */
    ss_output *csv;           /* NULL: not wanted */
    const char *program;      /* before what stderr is told; NULL: nothing is */
} ss_bridge_config;

enum { SS_BRIDGE_WAY = 512 };

typedef struct ss_bridge_summary {
    int64_t ticks, late_ticks, contact_ticks;
    int64_t forces, lost; /* lost: on the simulated bus, both directions */
    int64_t answered;     /* poses with at least one force */
    double peak_force_n, energy_in_j;
    double peak_indentation_m; /* of the newest force as the peak was exerted; 0 without a server */
    double latency_sum_us, max_latency_us; /* of the first force that answers a pose */
    int64_t others;     /* answers that another sender holds the probe; no forces */
    double other_s;     /* from the first of them to the first force after */
    bool was_inside;    /* the first forces were faded in: the hand began inside the tissue */
    bool has_stopped;   /* forces came, and were away at the end */
    bool has_gap;       /* they were away for a second or longer, and came again; or, in */
    double held_s;      /* seconds, the first time that this program did not run so long; else 0 */
    bool has_withheld;  /* two servers were heard, or another kept a contact from the hand */
    ss_halt halt;       /* forces of a server that is at fault or paused */
    int64_t changed_ns; /* another server answers in the first one's place since; 0: none does */
    bool is_complete;   /* ran to its own end, or has none and was stopped */
    /* Places that the tool was at: every `way_every`-th period's, thinned out when there is no more
     * room. For one that has missed the tissue. */
    double way[SS_BRIDGE_WAY][3];
    int32_t way_count;
    int64_t way_every;
} ss_bridge_summary;

typedef struct ss_bridge {
    /* parameters */
    ss_bridge_config config;
    ss_frame frame;
    ss_device device;

    /* state */
    ss_corrector corrector;
    int32_t seq;              /* of the last pose */
    bool is_served;           /* against a server, */
    bool wants_scene;         /* whose limits are not known */
    bool has_sample, is_over; /* over: no force is taken any more */
    ss_device_sample sample;  /* of the present tick */
    double velocity[3];       /* device frame, below 50 Hz */
    double device_force[3];   /* exerted since the last tick */
    double applied_world[3];  /* the same, world axes */
    int32_t answered_seq;     /* of the newest pose that was answered */
    int32_t force_seq;        /* of the force that came last, */
    int64_t heard_ns;         /* and when, before the simulated bus; 0: none has */
    ss_indentation indentation;
    double depth, indented;          /* of the newest force, for the CSV */
    int64_t start_ns, last_force_ns; /* the last: 0 before the first force */
    int64_t other_since_ns;          /* 0: no other sender holds the probe */
    bool is_change_told, is_fault_told, is_pause_told, is_withheld_told, is_held_told;
    int64_t held_ns;  /* when the program was held up; 0: was not */
    int64_t fault_ns; /* the model is at fault, or late, since; 0: was never */
    ss_withholding withholding;
    double told_most_n; /* that the scene heard last lets any force have; 0: not told yet */
    double most_n;      /* the first trusted server's */
    ss_bus *poses_out, *forces_in; /* NULL without a server */
    ss_bridge_summary summary;
} ss_bridge;

/* Fills `bridge`; takes the device over. */
softsim_status ss_bridge_init(ss_bridge *bridge, const ss_bridge_config *config,
                              const ss_frame *frame, const ss_device *device, softsim_error *error);
void ss_bridge_fini(ss_bridge *bridge);

/* Callbacks of the client; `context` is the ss_bridge. */
void ss_bridge_take_force(void *context, const softsim_force *force, int64_t receive_ns);
void ss_bridge_take_status(void *context, const softsim_server_status *status, int64_t receive_ns);
void ss_bridge_take_scene(void *context, const softsim_scene_report *scene);
/* Once a period, after what came in it. */
void ss_bridge_watch_servers(ss_bridge *bridge, const ss_speakers *heard, int64_t now_ns);
/* Runs in real time until the ticks are done, the device ends or a signal comes; false when LCM
 * failed. */
bool ss_bridge_run(ss_bridge *bridge, softsim_client *client);
/* Runs without LCM, as fast as possible, against F_z = max(0, -stiffness z) on the pose of
 * `delay_ticks` (0..1000) before, 0 until there is one. */
void ss_bridge_run_linear(ss_bridge *bridge, double stiffness_n_per_m, int32_t delay_ticks);
/* The line of the summary that tells the largest force and where: pressed in, or in a grasp pulled
 * out. */
void ss_bridge_print_peak(const ss_bridge_summary *summary, bool is_linear, FILE *out);
/* The header line of the CSV, with its \n: without a server, and with the columns that a server
 * adds; and what each is, for --help. */
extern const char ss_bridge_csv_header[];
extern const char ss_bridge_csv_server_header[];
extern const char ss_bridge_csv_help[];
