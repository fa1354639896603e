/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Types that every part of softsim shares: status codes, errors, a probe pose and a contact
 * force. They mirror the LCM messages of `lcmtypes/` field by field, so that a
 * value is decoded, checked and converted once and then carried unchanged from the socket to the
 * force that answers it.
 *
 * Units are SI base units (metres, newtons, seconds, kilograms, radians) in the world frame
 * unless a name says otherwise. Quaternions are w x y z and rotate tool vectors into the world.
 * Times that cross a process boundary are int64 microseconds (`utime`); times inside one process
 * are int64 nanoseconds of the monotonic clock (`_ns`).
 */
#include <stdbool.h>
#include <stdint.h>

/* Probes are numbered 0 .. SOFTSIM_MAX_PROBES - 1; the status message has one slot for each. */
#define SOFTSIM_MAX_PROBES 8

/* m: a pose with a coordinate beyond it is refused, so that no body there can be touched. */
#define SOFTSIM_FARTHEST_M 100.0

/* One list gives the enum, the names and the texts. */
#define SOFTSIM_STATUS_LIST(X)                                                                     \
    X(OK, 0, "done")                                                                               \
    X(ERROR_ARGUMENT, -1, "bad argument")                                                          \
    X(ERROR_FILE, -2, "cannot read the file")                                                      \
    X(ERROR_FORMAT, -3, "the file is not what it should be")                                       \
    X(ERROR_SCENE, -4, "the scene is not valid")                                                   \
    X(ERROR_MESH, -5, "the mesh cannot be used")                                                   \
    X(ERROR_MEMORY, -6, "out of memory")                                                           \
    X(ERROR_NETWORK, -7, "no network")                                                             \
    X(ERROR_UNSUPPORTED, -8, "not built into this program")                                        \
    X(ERROR_SYSTEM, -9, "the system refused")

typedef enum softsim_status {
#define X(name, value, text) SOFTSIM_##name = (value),
    SOFTSIM_STATUS_LIST(X)
#undef X
} softsim_status;

#define SOFTSIM_ERROR_TEXT_SIZE 8192

/* What went wrong: one line per fault, each `file:line:column: what, what to do instead`. */
typedef struct softsim_error {
    softsim_status status;
    int32_t fault_count;
    char text[SOFTSIM_ERROR_TEXT_SIZE]; /* lines separated by \n, no \n at the end */
} softsim_error;

/* Button bits of a pose. */
enum { SOFTSIM_BUTTON_GRASP = 1 };

/* Flags of a pose. */
enum { SOFTSIM_POSE_CORRECTS = 1 }; /* the client corrects forces between messages */

/* A probe pose: what probe_pose_t carries, checked. */
typedef struct softsim_pose {
    int64_t utime_us; /* the sender's own clock; compared with itself only */
    int64_t sender;
    int64_t receive_ns; /* our monotonic clock at receipt; 0 in lockstep and headless runs */
    uint64_t source;    /* address and port that it came from; 0 where there is none */
    int32_t seq;
    int32_t probe;
    int32_t buttons;
    int32_t force_seq; /* seq of the force in effect from this sample on; -1 unknown */
    int32_t flags;
    double position[3];
    double orientation[4];
    double velocity[3];      /* NaN where the device does not know */
    double applied_force[3]; /* NaN where the device does not know */
} softsim_pose;

/* Flags of a force. */
enum {
    SOFTSIM_FORCE_CONTACT = 1,
    SOFTSIM_FORCE_PREDICTED = 2, /* no fresh model result this tick */
    SOFTSIM_FORCE_LIMITED = 4,
    SOFTSIM_FORCE_RAMPING = 8, /* down, or on entry */
    SOFTSIM_FORCE_STALE = 16,
    SOFTSIM_FORCE_OTHER_SENDER = 32,
    SOFTSIM_FORCE_MODEL_FAULT = 64,
    SOFTSIM_FORCE_GRASPING = 128
};

/* A contact force: what contact_force_t carries. */
typedef struct softsim_force {
    int64_t utime_us;
    int64_t sender; /* of the pose that it answers */
    int64_t pose_utime_us;
    int32_t seq;
    int32_t probe;
    int32_t pose_seq;
    /* More than 0 with flag 1 and only then. 1 also of a tool that is all inside the tissue and not
     * held off, and while the force of a contact that has ended goes away (20 ms; of a grasp at
     * most 0.2 s). Without flag 1 there is no force, torque or depth. */
    int32_t contact_count;
    int32_t model_age_us;
    int32_t flags;
    double force[3];       /* on the device's hand, at the tool's origin */
    double torque[3];      /* about the tool's origin */
    double model_force[3]; /* the model's reaction before coupling and limits */
    double point[3];       /* on the deformed surface */
    double normal[3];      /* out of the tissue */
    double proxy[3];
    double depth;     /* m, how far the raw tool is inside the deformed surface, of one that is all
                         inside its way out; never more than the body is thick */
    double stiffness; /* N/m, felt dF/dx along the normal; 0 when free, limited or ramping */
} softsim_force;

/* Reasons for refusing a pose, the index into poses_refused, on the wire too. Not finite: also a
 * quaternion that is not a unit one. One list gives the enum and the names. */
#define SOFTSIM_REFUSAL_LIST(X)                                                                    \
    X(MALFORMED, 0, "malformed")                                                                   \
    X(TYPE_HASH, 1, "wrong type")                                                                  \
    X(NOT_FINITE, 2, "not finite")                                                                 \
    X(STALE, 3, "stale")                                                                           \
    X(JUMP, 4, "jump")                                                                             \
    X(OTHER_SENDER, 5, "other sender")                                                             \
    X(WRONG_PROBE, 6, "wrong probe")                                                               \
    X(OTHER, 7, "other")

typedef enum softsim_refusal {
    SOFTSIM_ACCEPTED = -1,
#define X(name, value, text) SOFTSIM_REFUSED_##name = (value),
    SOFTSIM_REFUSAL_LIST(X)
#undef X
        SOFTSIM_REFUSED_COUNT
} softsim_refusal;

/* Guarded: sub-stepped or clamped, result trusted. Degraded: slower than real time, or damped.
 * Fault: non-finite; last good state restored, force ramped to zero. */
#define SOFTSIM_VERDICT_LIST(X)                                                                    \
    X(GOOD, 0, "good")                                                                             \
    X(GUARDED, 1, "guarded")                                                                       \
    X(DEGRADED, 2, "degraded")                                                                     \
    X(FAULT, 3, "fault")

typedef enum softsim_verdict {
#define X(name, value, text) SOFTSIM_VERDICT_##name = (value),
    SOFTSIM_VERDICT_LIST(X)
#undef X
} softsim_verdict;

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Name ("ERROR_MESH") and text of a status. Thread: any; RT-safe. */
const char *softsim_status_name(softsim_status status);
const char *softsim_status_text(softsim_status status);
/* "guarded", "wrong probe"; "unknown" for any other. Thread: any; RT-safe. */
const char *softsim_verdict_name(softsim_verdict verdict);
const char *softsim_refusal_name(softsim_refusal refusal);

/* Appends one fault line (printf form) to `error` and sets its status when it had none. What is
 * filled in stays on that line. NULL is accepted and does nothing. Thread: set-up only. */
void softsim_error_add(softsim_error *error, softsim_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* The same with a text that was put together before, such as another error's: its lines stay. */
void softsim_error_append(softsim_error *error, softsim_status status, const char *text);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
