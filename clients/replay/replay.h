/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Plays recorded poses to a server and keeps the answers.
 *
 * Paced: every pose is sent at its time of the log, on the absolute clock; answers are taken
 * whenever they come. Lockstep: a pose is sent, and again every 100 ms, until its answer is here;
 * then the next. Either ends in failure when 5 s pass without any answer to what was sent.
 *
 * A server that is started again, or another in its place, has a body that has felt nothing of the
 * log so far. A lockstep replay, whose forces are a result, ends there, before the first of them;
 * a paced one is played on to it. At the end of a paced one, when no answer is of the last half
 * second of the log, a server that is only late is waited for, as long as anywhere in the log.
 *
 * What else makes the forces others than those of the log is noted, and played on: poses refused
 * since another sender holds the probe, which a paced replay waits for before it begins (claim.h);
 * a second of a paced one without an answer, or in which this program did not run (it was
 * suspended) and after which it sends at once what is late; a probe of which no pose was answered,
 * or none at its end; in lockstep, ticks that others' poses made (ticks.h); forces of a server that
 * is at fault or paused (halt.h).
 *
 * Thread: main.
 */
#include <stdbool.h>
#include <stdint.h>

#include "claim.h"
#include "halt.h"
#include "indentation.h"
#include "output.h"
#include "softsim/client.h"
#include "softsim/log.h"
#include "ticks.h"

/* Latencies are counted in buckets of 1 us up to here; longer ones in the last. */
enum { SS_REPLAY_BUCKETS = 100 * 1000, SS_REPLAY_SENT = 4096 };

typedef struct ss_replay_statistics {
    int64_t poses;    /* sent, repeats of lockstep not counted */
    int64_t answered; /* poses that at least one force answers */
    int64_t forces;   /* that answer this sender */
    int64_t resent;
    int64_t duplicates;   /* second answers in lockstep, not kept */
    int64_t other_sender; /* forces that say that another sender holds the probe */
    int64_t other_ticks;  /* of a lockstep server's world, made by the poses of others */
    double peak_force_n;
    int64_t latency_count, max_latency_us; /* of the first answer to each pose */
    uint32_t latency[SS_REPLAY_BUCKETS];
} ss_replay_statistics;

/* What is asked of one probe, and answered. */
typedef struct ss_replay_asked {
    bool is_asking;    /* a pose was sent since its last answer, */
    int32_t seq;       /* the first of those, */
    int64_t us;        /* and its time in the log */
    int64_t silent_ns; /* waited since then */
    int64_t sent_us;   /* time in the log since then in which poses were sent: no pause of it */
    int64_t played_us; /* time in the log of the last pose sent */
    int32_t felt_seq;  /* the newest that this sender's force answers; 0: none */
    int64_t felt_us;   /* its time in the log */
} ss_replay_asked;

typedef struct ss_replay {
    /* parameters */
    softsim_poses *poses;
    double speed;          /* 2: twice as fast as recorded */
    int64_t repeat;        /* times the whole log is played */
    int64_t repeat_gap_us; /* between the last pose and the first again */
    bool is_lockstep;
    ss_output csv;              /* not open: not wanted */
    softsim_log_writer *record; /* NULL: not wanted */

    /* state */
    softsim_client *client;
    ss_indentation indentation[SOFTSIM_MAX_PROBES];
    double sent_position[SS_REPLAY_SENT][3]; /* by seq; of older ones the answers are late */
    int64_t sent_us[SS_REPLAY_SENT];         /* their times in the log */
    ss_replay_asked asked[SOFTSIM_MAX_PROBES];
    ss_claim claim;
    ss_ticks ticks;
    bool is_uncounted; /* whose ticks they were is not known: the server's count was not heard */
    ss_halt halt;
    bool is_over;                       /* nothing that comes is kept */
    int32_t refused_seq, refused_probe; /* the first refused for another sender; 0: none */
    int32_t gap_seq;     /* the first of those that went without an answer for long; 0: none */
    int64_t gap_us;      /* its time in the log, */
    double gap_s;        /* and how long */
    int64_t late_ns;     /* behind the log's time, as the last pose was sent */
    int32_t held_seq;    /* the first pose before which this program was held up; 0: none */
    double held_s;       /* for so long */
    int32_t changed_seq; /* the first that another server answers; 0: none */
    bool has_told_lost;  /* that a recording could not be written on */
    int32_t seq;         /* of the last pose sent */
    int32_t answered_seq[SOFTSIM_MAX_PROBES]; /* the newest answered, by channel */
    int32_t sent_seq[SOFTSIM_MAX_PROBES];     /* the last sent, by channel */
    bool is_asking;               /* a pose was sent since the last answer, of whichever probe */
    int64_t silent_ns, looked_ns; /* waited for one since then; last look at the clock */
    bool has_heard_two;           /* servers; the first one's answers are kept */
    ss_replay_statistics statistics;
} ss_replay;

typedef enum ss_replay_result {
    SS_REPLAY_DONE,
    SS_REPLAY_STOPPED, /* by a signal */
    SS_REPLAY_SILENT,  /* 5 s without an answer */
    SS_REPLAY_CHANGED, /* lockstep: another server answers */
    SS_REPLAY_HELD,    /* another sender did not let go of a probe: nothing was played */
    SS_REPLAY_BROKEN   /* LCM failed */
} ss_replay_result;

/* Callbacks of the client; `context` is the ss_replay. */
void ss_replay_take_force(void *context, const softsim_force *force, int64_t receive_ns);
void ss_replay_take_status(void *context, const softsim_server_status *status, int64_t receive_ns);
/* Plays; the parameters and `client` are set, the rest is zero. */
ss_replay_result ss_replay_run(ss_replay *replay);
/* A probe whose answers ended over half a second of the log before its poses did, and not for
 * lateness; that was answered at all. -1: none. */
int32_t ss_replay_ended_unanswered(const ss_replay *replay);
/* A probe of which no pose was answered, though others' were; -1: none. */
int32_t ss_replay_never_answered(const ss_replay *replay);
/* `quantile` in 0..1, microseconds; 0 without answers. */
int64_t ss_replay_latency(const ss_replay_statistics *statistics, double quantile);
/* The header line of the CSV, with its \n; and what each column is, for --help. */
extern const char ss_replay_csv_header[];
extern const char ss_replay_csv_help[];
