/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "bridge.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "parameter.h"
#include "process.h"
#include "rt/memory.h"
#include "rt/plain.h"
#include "rt/program.h"
#include "rt/vec.h"

static const double velocity_cutoff_hz = 50.0;
static const double least_slew_n_per_s = 10.0;   /* that a server takes */
static const double usual_slew_n_per_s = 2000.0; /* until it has told its own */
static const int64_t away_ns = 250000000;        /* without a force: they have stopped */
static const int64_t long_ns = 1000000000;       /* and what was recorded has a gap */
static const int64_t unclear_ns = 600000000;     /* in which two statuses come */
enum {
    FIRST_FORCES = 100, /* in which a start inside the tissue shows */
    LATE_FORCES = 100   /* a force numbered lower by more is of a server that was started again */
};

#define COLUMNS "tick,x,y,z,vx,vy,vz,qx,qy,qz,fx,fy,fz,energy_in_j"
const char ss_bridge_csv_header[] = COLUMNS "\n";
const char ss_bridge_csv_server_header[] =
    COLUMNS ",time_s,probe,ow,ox,oy,oz,buttons,depth_m,indentation_m\n";
const char ss_bridge_csv_help[] =
    "one row per period; SI units, world frame; written to OUT.csv.part once a\n"
    "second, and OUT.csv when complete: one server, neither paused nor at fault,\n"
    "was felt to the end; softsim-replay plays it again:\n"
    "  tick           number of the period\n"
    "  x,y,z          where the device is\n"
    "  vx,vy,vz       its velocity\n"
    "  qx,qy,qz       the position that was measured and sent\n"
    "  fx,fy,fz       force that the device exerted in this period\n"
    "  energy_in_j    energy that the device has taken from the hand so far\n"
    "and, of a server:\n"
    "  time_s, probe  from the first period on; its number\n"
    "  ow,ox,oy,oz    the orientation that was sent, a quaternion\n"
    "  buttons        that were sent, one bit each\n"
    "  depth_m        how deep the tool is in the surface that yields to it: what is\n"
    "                 left between the two, not how far it was pressed\n"
    "  indentation_m  how far the tool was pressed in since it first touched, along the\n"
    "                 normal: a press of 10 mm is 0.010";

softsim_status ss_bridge_init(ss_bridge *bridge, const ss_bridge_config *config,
                              const ss_frame *frame, const ss_device *device, softsim_error *error)
{
    *bridge = (ss_bridge){.config = *config, .frame = *frame, .device = *device};
    ss_corrector_init(&bridge->corrector, config->is_correcting, ss_corrector_unlimited);
    ss_bus_config out = config->bus;
    ss_bus_config in = config->bus;
    out.seed = config->bus.seed ^ 0x706F7365u; /* streams of their own */
    in.seed = config->bus.seed ^ 0x666F7263u;
    bridge->poses_out = ss_bus_create(&out, sizeof(softsim_pose));
    bridge->forces_in = ss_bus_create(&in, sizeof(softsim_force));
    if (bridge->poses_out == NULL || bridge->forces_in == NULL) {
        ss_bridge_fini(bridge);
        return ss_memory_fault(error);
    }
    return SOFTSIM_OK;
}

void ss_bridge_fini(ss_bridge *bridge)
{
    ss_bus_destroy(&bridge->poses_out);
    ss_bus_destroy(&bridge->forces_in);
    if (bridge->device.destroy != NULL) {
        bridge->device.destroy(bridge->device.state);
    }
    bridge->device = (ss_device){0};
}

/* What a full pipe or a stopped terminal has no room for is left out: the loop would wait with the
 * last force exerted. False then. */
__attribute__((format(printf, 2, 3))) static bool tell(const ss_bridge *bridge, const char *format,
                                                       ...)
{
    if (bridge->config.program == NULL || !ss_program_can_tell()) {
        return false;
    }
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ss_plain_print(stderr, "%s: %s\n", bridge->config.program, text);
    return true;
}

/* ---- one tick ---- */

/* `moved`: since the sample that is written, for the velocity of a device that knows none. */
static void write_row(ss_bridge *bridge, const double moved[3])
{
    double columns[12], velocity[3];
    ss_scale3(velocity, moved, 1.0 / bridge->device.period_s);
    for (int i = 0; i < 3; ++i) {
        const double known = bridge->sample.true_velocity[i];
        velocity[i] = isnan(known) ? velocity[i] : known;
    }
    ss_frame_position(&bridge->frame, bridge->sample.true_position, columns);
    ss_frame_velocity(&bridge->frame, velocity, columns + 3);
    ss_frame_position(&bridge->frame, bridge->sample.position, columns + 6);
    ss_copy3(columns + 9, bridge->applied_world);
    FILE *csv = bridge->config.csv->file;
    fprintf(csv, "%" PRId64, bridge->summary.ticks - 1);
    for (int i = 0; i < 12; ++i) {
        fprintf(csv, ",%.17g", columns[i]);
    }
    fprintf(csv, ",%.17g", bridge->summary.energy_in_j);
    if (bridge->is_served) {
        double turn[4];
        ss_frame_orientation(&bridge->frame, bridge->sample.orientation, turn);
        fprintf(csv, ",%.17g,%" PRId32 ",%.17g,%.17g,%.17g,%.17g,%" PRId32 ",%.17g,%.17g",
                bridge->device.period_s * (double)(bridge->summary.ticks - 1), bridge->config.probe,
                turn[0], turn[1], turn[2], turn[3], bridge->sample.buttons & SOFTSIM_BUTTON_GRASP,
                bridge->depth, bridge->indented);
    }
    fputc('\n', csv);
    if (!ss_output_pace(bridge->config.csv)) {
        (void)tell(bridge, "%s cannot be written on; is the disk full?", bridge->config.csv->path);
        bridge->config.csv = NULL;
    }
}

/* Reads the device and settles the tick before: its energy and its row. False at its end. */
static bool read_device(ss_bridge *bridge)
{
    ss_device_sample sample;
    if (!bridge->device.read(bridge->device.state, &sample)) {
        return false;
    }
    if (bridge->has_sample) {
        const double period_s = bridge->device.period_s;
        const double alpha = 1.0 - exp(-2.0 * SS_PI * velocity_cutoff_hz * period_s);
        double moved[3];
        ss_sub3(moved, sample.true_position, bridge->sample.true_position);
        bridge->summary.energy_in_j -= ss_dot3(bridge->device_force, moved);
        for (int i = 0; i < 3; ++i) {
            const double raw = (sample.position[i] - bridge->sample.position[i]) / period_s;
            bridge->velocity[i] += alpha * (raw - bridge->velocity[i]);
        }
        if (bridge->config.csv != NULL) {
            write_row(bridge, moved);
        }
    }
    bridge->sample = sample;
    bridge->has_sample = true;
    return true;
}

/* Makes the pose of this tick, numbered and remembered. */
static void make_pose(ss_bridge *bridge, int64_t now_ns, softsim_pose *out_pose)
{
    *out_pose = (softsim_pose){.utime_us = now_ns / 1000,
                               .seq = ++bridge->seq,
                               .probe = bridge->config.probe,
                               .buttons = bridge->sample.buttons & SOFTSIM_BUTTON_GRASP,
                               .flags = bridge->config.is_correcting ? SOFTSIM_POSE_CORRECTS : 0};
    ss_frame_position(&bridge->frame, bridge->sample.position, out_pose->position);
    ss_frame_orientation(&bridge->frame, bridge->sample.orientation, out_pose->orientation);
    ss_set3(out_pose->velocity, NAN, NAN, NAN); /* a device measures positions */
    ss_copy3(out_pose->applied_force, bridge->applied_world);
    ss_corrector_note_pose(&bridge->corrector, bridge->seq, now_ns, out_pose->position);
}

static void note_place(ss_bridge_summary *s, const double position[3])
{
    s->way_every = s->way_every > 0 ? s->way_every : 1;
    if (s->ticks % s->way_every != 0) {
        return;
    }
    if (s->way_count == SS_BRIDGE_WAY) {
        s->way_count = SS_BRIDGE_WAY / 2;
        s->way_every *= 2;
        for (int32_t i = 0; i < s->way_count; ++i) {
            ss_copy3(s->way[i], s->way[2 * i]);
        }
        if (s->ticks % s->way_every != 0) {
            return;
        }
    }
    ss_copy3(s->way[s->way_count++], position);
}

/* The bridge's own damping of a contact: at most what the contact exerts, so that tissue does not
 * pull, and with it within the server's limit. */
static void add_damping(const ss_bridge *bridge, double device[3])
{
    const double size = ss_norm3(device);
    const double limit = bridge->frame.force_scale * bridge->corrector.limits.force_n;
    double damping[3];
    ss_scale3(damping, bridge->velocity, -bridge->config.damping_n_s_per_m);
    (void)ss_clamp_norm3(damping, size);
    ss_madd3(device, device, 1.0, damping);
    (void)ss_clamp_norm3(device, fmax(size, limit));
}

/* Once, as soon as stderr takes it, that a contact is not felt: two may be told only later. */
static void tell_withheld(ss_bridge *bridge)
{
    bridge->summary.has_withheld = true;
    if (!bridge->is_withheld_told) {
        bridge->is_withheld_told = tell(bridge, "nothing is felt: another server answers too");
    }
}

/* Exerts the force in effect for one period, corrected to `pose`, and names it there. */
static void exert(ss_bridge *bridge, int64_t now_ns, softsim_pose *pose)
{
    double world[3], device[3];
    pose->force_seq = ss_corrector_force_seq(&bridge->corrector, now_ns);
    ss_corrector_force(&bridge->corrector, now_ns, pose->position, world);
    if (bridge->withholding.share > 0.0) {
        ss_scale3(world, world, 1.0 - bridge->withholding.share);
        ss_corrector_withhold(&bridge->corrector, bridge->withholding.share);
    }
    ss_frame_force_to_device(&bridge->frame, world, device);
    const bool is_contact =
        pose->force_seq >= 0 && (bridge->corrector.force.flags & SOFTSIM_FORCE_CONTACT) != 0;
    if (is_contact) {
        add_damping(bridge, device);
    }
    if (is_contact && ss_withholding_is_waiting(&bridge->withholding)) {
        tell_withheld(bridge);
    }
    const double most =
        bridge->most_n > 0.0 ? bridge->frame.force_scale * bridge->most_n : INFINITY;
    (void)ss_clamp_norm3(device, fmin(bridge->device.max_exerted_n, most));
    note_place(&bridge->summary, pose->position);
    ss_copy3(bridge->device_force, device);
    ss_frame_force_to_world(&bridge->frame, device, bridge->applied_world);
    bridge->device.exert(bridge->device.state, device);
    if (ss_norm3(device) > bridge->summary.peak_force_n) {
        bridge->summary.peak_force_n = ss_norm3(device);
        bridge->summary.peak_indentation_m = bridge->indented;
    }
    bridge->summary.contact_ticks += is_contact;
    ++bridge->summary.ticks;
}

/* ---- against a server ---- */

/* Whoever told the limits may not be the server whose force comes now: it is the first, forces had
 * stopped, or they are numbered anew. */
static bool may_be_another(const ss_bridge *bridge, const softsim_force *force, int64_t receive_ns)
{
    return bridge->heard_ns == 0 || receive_ns - bridge->heard_ns > away_ns ||
           (int64_t)bridge->force_seq - force->seq > LATE_FORCES;
}

/* Those of another server are none of this one's; it is asked for its own. */
static void forget_limits(ss_bridge *bridge)
{
    bridge->corrector.limits = (ss_corrector_limits){0.0, usual_slew_n_per_s};
    bridge->told_most_n = 0.0;
    bridge->wants_scene = true;
}

void ss_bridge_take_force(void *context, const softsim_force *force, int64_t receive_ns)
{
    ss_bridge *bridge = context;
    if (force->probe != bridge->config.probe || bridge->is_over) {
        return;
    }
    if ((force->flags & SOFTSIM_FORCE_OTHER_SENDER) == 0) {
        if (may_be_another(bridge, force, receive_ns)) {
            forget_limits(bridge);
        }
        bridge->force_seq = force->seq;
        bridge->heard_ns = receive_ns;
    }
    bridge->summary.lost += !ss_bus_send(bridge->forces_in, receive_ns, force);
}

void ss_bridge_take_status(void *context, const softsim_server_status *status, int64_t receive_ns)
{
    (void)receive_ns;
    ss_halt_take_status(&((ss_bridge *)context)->summary.halt, status);
}

void ss_bridge_take_scene(void *context, const softsim_scene_report *scene)
{
    ss_bridge *bridge = context;
    ss_corrector_limits *limits = &bridge->corrector.limits;
    const double slew = ss_parameter_of(scene, "haptic.max_slew_n_per_s");
    limits->force_n = ss_parameter_of(scene, "haptic.max_force_n");
    limits->slew_n_per_s = slew >= least_slew_n_per_s ? slew : usual_slew_n_per_s;
    bridge->told_most_n = ss_parameter_most(scene, "haptic.max_force_n");
}

/* Another sender holds the probe: its zero force stops what was felt, but is no force of ours. */
static void note_other(ss_bridge *bridge, int64_t arrival_ns)
{
    ++bridge->summary.others;
    if (bridge->other_since_ns == 0) {
        bridge->other_since_ns = arrival_ns;
    }
}

/* Of a pose that is remembered; else not finite. */
static const double *sent_position(const ss_bridge *bridge, int32_t seq)
{
    static const double unknown[3] = {NAN, NAN, NAN};
    const uint32_t slot = (uint32_t)seq % SS_CORRECT_HISTORY;
    return bridge->corrector.history[slot].seq == seq ? bridge->corrector.history[slot].position
                                                      : unknown;
}

static void note_force(ss_bridge *bridge, const softsim_force *force, int64_t arrival_ns)
{
    ss_bridge_summary *summary = &bridge->summary;
    if (bridge->other_since_ns != 0) {
        summary->other_s += 1e-9 * (double)(arrival_ns - bridge->other_since_ns);
        bridge->other_since_ns = 0;
    }
    if (summary->has_stopped) {
        (void)tell(bridge, "forces again at %.1f s, after %.1f s",
                   1e-9 * (double)(arrival_ns - bridge->start_ns),
                   1e-9 * (double)(arrival_ns - bridge->last_force_ns));
        summary->has_stopped = false;
        summary->has_gap |= arrival_ns - bridge->last_force_ns >= long_ns;
    }
    bridge->last_force_ns = arrival_ns;
    ++summary->forces;
    bridge->depth = (force->flags & SOFTSIM_FORCE_CONTACT) != 0 ? force->depth : 0.0;
    bridge->indented =
        ss_indentation_take(&bridge->indentation, force, sent_position(bridge, force->pose_seq));
    ss_halt_take_force(&summary->halt, force, force->pose_seq > bridge->answered_seq);
    summary->was_inside |= summary->forces <= FIRST_FORCES && summary->others == 0 &&
                           force->depth > 0.0 && (force->flags & SOFTSIM_FORCE_RAMPING) != 0;
    if (force->pose_seq > bridge->answered_seq && force->pose_seq <= bridge->seq) {
        const double latency_us = 1e-3 * (double)arrival_ns - (double)force->pose_utime_us;
        bridge->answered_seq = force->pose_seq;
        ++summary->answered;
        summary->latency_sum_us += latency_us;
        summary->max_latency_us = fmax(summary->max_latency_us, latency_us);
    }
}

/* Puts every force that has arrived into effect; the last one stays. */
static void take_arrived(ss_bridge *bridge, int64_t now_ns)
{
    softsim_force force;
    for (;;) {
        const int64_t arrival_ns = ss_bus_due(bridge->forces_in);
        if (!ss_bus_receive(bridge->forces_in, now_ns, &force)) {
            break;
        }
        ss_corrector_take_force(&bridge->corrector, &force, arrival_ns);
        if ((force.flags & SOFTSIM_FORCE_OTHER_SENDER) != 0) {
            note_other(bridge, arrival_ns);
        } else {
            note_force(bridge, &force, arrival_ns);
        }
    }
    if (bridge->summary.forces > 0 && !bridge->summary.has_stopped &&
        now_ns - bridge->last_force_ns > away_ns) {
        bridge->summary.has_stopped = true;
        (void)tell(bridge, "forces stopped at %.1f s; %s",
                   1e-9 * (double)(bridge->last_force_ns - bridge->start_ns),
                   bridge->other_since_ns != 0 ? "another sender has taken the probe"
                                               : "is softsimd still running?");
    }
}

/* Keeps the force from the hand while it is not sure that one server answers, and which. */
void ss_bridge_watch_servers(ss_bridge *bridge, const ss_speakers *heard, int64_t now_ns)
{
    ss_bridge_summary *summary = &bridge->summary;
    if (heard->changes != bridge->withholding.before.changes) {
        summary->changed_ns = summary->changed_ns == 0 ? now_ns : summary->changed_ns;
        forget_limits(bridge);
    }
    ss_withholding_step(&bridge->withholding, heard, bridge->corrector.present > 0.0, now_ns,
                        bridge->device.period_s);
    if (bridge->withholding.is_trusted && !(bridge->most_n > 0.0)) {
        bridge->most_n = bridge->told_most_n;
    }
    if (bridge->config.program != NULL) {
        ss_process_tell_two(bridge->config.program, "the force is let go", heard->are_two);
    }
    summary->has_withheld = summary->has_withheld || heard->are_two;
}

static ss_speakers read_speakers(const ss_bridge *bridge, const softsim_client *client)
{
    return (ss_speakers){.has_force = bridge->summary.forces > 0,
                         .are_two = softsim_client_hears_two(client),
                         .second = softsim_client_read_counts(client).second_forces,
                         .changes = softsim_client_server_changes(client)};
}

/* A period that was due at `tick_ns` and comes so late that what it would have felt is missing,
 * though forces that lay unread meanwhile look as if none had been away. */
static void note_held(ss_bridge *bridge, int64_t tick_ns, int64_t now_ns)
{
    ss_bridge_summary *summary = &bridge->summary;
    if (now_ns - tick_ns >= long_ns && bridge->held_ns == 0) {
        bridge->held_ns = tick_ns;
        summary->held_s = 1e-9 * (double)(now_ns - tick_ns);
        summary->has_gap = true;
    }
    if (bridge->held_ns != 0 && !bridge->is_held_told) {
        bridge->is_held_told =
            tell(bridge,
                 "this program was held up for %.1f s at %.1f s: nothing was felt or exerted anew "
                 "meanwhile; start the bridge again",
                 summary->held_s, 1e-9 * (double)(bridge->held_ns - bridge->start_ns));
    }
}

/* Another server is taken up, but said once, as soon as stderr takes it: the hand may stand deep in
 * a body that is elsewhere. */
static void tell_change(ss_bridge *bridge)
{
    const ss_bridge_summary *summary = &bridge->summary;
    if (summary->changed_ns != 0 && !bridge->is_change_told) {
        bridge->is_change_told =
            tell(bridge,
                 "another server answers since %.1f s: its body has felt nothing before, and may "
                 "be another; start the bridge again, which finds its tissue",
                 1e-9 * (double)(summary->changed_ns - bridge->start_ns));
    }
}

/* The same of a server that is at fault or paused: the hand may wait for its reset. Why, a status
 * tells, which is asked for. */
static void note_halt(ss_bridge *bridge, softsim_client *client, int64_t now_ns)
{
    const ss_halt *halt = &bridge->summary.halt;
    if (halt->fault_seq != 0 && bridge->fault_ns == 0) {
        bridge->fault_ns = now_ns;
        (void)softsim_client_send_command(client, "status", "");
    }
    if (bridge->fault_ns != 0 && !bridge->is_fault_told &&
        (ss_halt_is_clear(halt) || now_ns - bridge->fault_ns > unclear_ns)) {
        const bool has_reason = halt->reason[0] != '\0';
        bridge->is_fault_told =
            tell(bridge, "the server's model is %s since %.1f s%s%s%s, and no force comes: %s",
                 ss_halt_name(halt), 1e-9 * (double)(bridge->fault_ns - bridge->start_ns),
                 has_reason ? " (" : "", halt->reason, has_reason ? ")" : "", ss_halt_cure(halt));
    }
    if (halt->pause_seq != 0 && !bridge->is_pause_told) {
        bridge->is_pause_told = tell(bridge,
                                     "the server is paused at %.1f s, and no force comes: "
                                     "`softsim-monitor --command resume`",
                                     1e-9 * (double)(now_ns - bridge->start_ns));
    }
}

/* Is the run over? One that has an end of its own is complete only there. */
static bool is_over(ss_bridge *bridge)
{
    const bool is_at_end = !read_device(bridge) ||
                           bridge->summary.ticks >= bridge->config.tick_count ||
                           bridge->seq == INT32_MAX;
    bridge->summary.is_complete = is_at_end || bridge->config.is_endless;
    return is_at_end || ss_process_is_stopped();
}

/* What was still going on at the end. */
static void close_summary(ss_bridge *bridge)
{
    if (bridge->other_since_ns != 0) {
        bridge->summary.other_s +=
            1e-9 * (double)(softsim_client_now_ns() - bridge->other_since_ns);
        bridge->other_since_ns = 0;
    }
}

static void send_due(ss_bridge *bridge, softsim_client *client, int64_t now_ns)
{
    softsim_pose pose;
    while (ss_bus_receive(bridge->poses_out, now_ns, &pose)) {
        softsim_client_send_pose(client, &pose, bridge->config.probe);
    }
}

/* Waits for `tick_ns`, receiving forces and sending the poses that fall due. False when LCM is
 * broken. */
static bool wait_for_tick(ss_bridge *bridge, softsim_client *client, int64_t tick_ns)
{
    int64_t now_ns;
    do {
        const int64_t due_ns = ss_bus_due(bridge->poses_out);
        if (softsim_client_wait(client, due_ns < tick_ns ? due_ns : tick_ns) < 0) {
            return false;
        }
        now_ns = softsim_client_now_ns();
        send_due(bridge, client, now_ns);
    } while (now_ns < tick_ns && !ss_process_is_stopped());
    return true;
}

/* Whatever is said and written after the loop, the hand is let go first. */
static void let_go(const ss_bridge *bridge)
{
    static const double none[3] = {0.0, 0.0, 0.0};
    bridge->device.exert(bridge->device.state, none);
}

bool ss_bridge_run(ss_bridge *bridge, softsim_client *client)
{
    const int64_t period_ns = (int64_t)(1e9 * bridge->device.period_s);
    const int64_t sender = softsim_client_sender(client);
    int64_t tick_ns = softsim_client_now_ns();
    bridge->start_ns = tick_ns;
    bridge->is_served = true;
    ss_withholding_begin(&bridge->withholding);
    for (;;) {
        if (!wait_for_tick(bridge, client, tick_ns)) {
            bridge->summary.is_complete = false;
            let_go(bridge);
            return false;
        }
        const int64_t now_ns = softsim_client_now_ns();
        note_held(bridge, tick_ns, now_ns);
        take_arrived(bridge, now_ns);
        const ss_speakers heard = read_speakers(bridge, client);
        ss_bridge_watch_servers(bridge, &heard, now_ns);
        tell_change(bridge);
        note_halt(bridge, client, now_ns);
        if (bridge->wants_scene) {
            bridge->wants_scene = false;
            (void)softsim_client_send_command(client, "refresh", "");
        }
        if (is_over(bridge)) {
            close_summary(bridge);
            let_go(bridge);
            bridge->is_over = true;
            ss_halt_ask(&bridge->summary.halt, client);
            return true;
        }
        softsim_pose pose;
        make_pose(bridge, now_ns, &pose);
        exert(bridge, now_ns, &pose);
        pose.sender = sender;
        bridge->summary.lost += !ss_bus_send(bridge->poses_out, now_ns, &pose);
        send_due(bridge, client, now_ns);
        tick_ns += period_ns;
        if (now_ns > tick_ns) {
            ++bridge->summary.late_ticks;
            tick_ns = now_ns;
        }
    }
}

/* ---- against a linear tissue ---- */

void ss_bridge_run_linear(ss_bridge *bridge, double stiffness_n_per_m, int32_t delay_ticks)
{
    while (!is_over(bridge)) {
        const int64_t now_ns =
            (int64_t)(1e9 * bridge->device.period_s * (double)bridge->summary.ticks);
        softsim_pose pose;
        make_pose(bridge, now_ns, &pose);
        const int32_t answered = bridge->seq - delay_ticks;
        if (answered >= 1) {
            const double z = bridge->corrector.history[answered % SS_CORRECT_HISTORY].position[2];
            softsim_force force = {.probe = pose.probe,
                                   .seq = answered,
                                   .pose_seq = answered,
                                   .flags = z < 0.0 ? SOFTSIM_FORCE_CONTACT : 0,
                                   .normal = {0.0, 0.0, 1.0},
                                   .stiffness = stiffness_n_per_m};
            force.force[2] = fmax(0.0, -stiffness_n_per_m * z);
            ss_corrector_take_force(&bridge->corrector, &force, now_ns);
            ++bridge->summary.forces;
        }
        exert(bridge, now_ns, &pose);
    }
}

/* ---- summary ---- */

void ss_bridge_print_peak(const ss_bridge_summary *summary, bool is_linear, FILE *out)
{
    const double in_mm = 1e3 * summary->peak_indentation_m;
    fprintf(out, "peak force  %.6g N", summary->peak_force_n);
    if (!is_linear && summary->peak_force_n > 0.0) {
        fprintf(out, in_mm < 0.0 ? ", pulled %.3g mm" : " at %.3g mm of indentation", fabs(in_mm));
    }
    fputc('\n', out);
}
