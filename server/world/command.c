/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "world/field.h"
#include "world/world.h"

/* Commands as they come over the wire: judged, answered, and handed to the loops they concern. */

/* What the hand feels may be lowered by a command, not raised: the name of such a key, and the
 * scene's value. NULL of the others. */
static const char *felt_limit(const ss_scene *scene, ss_scene_live_key key, double *out_most)
{
    switch (key) {
    case SS_LIVE_MAX_FORCE:
        *out_most = scene->max_force_n;
        return "haptic.max_force_n";
    case SS_LIVE_MAX_SLEW:
        *out_most = scene->max_slew_n_per_s;
        return "haptic.max_slew_n_per_s";
    case SS_LIVE_COUPLING_STIFFNESS:
        *out_most = scene->coupling_stiffness_n_per_m;
        return "haptic.coupling.stiffness_n_per_m";
    case SS_LIVE_COUPLING_DAMPING:
        *out_most = scene->coupling_damping_n_s_per_m;
        return "haptic.coupling.damping_n_s_per_m";
    default:
        return NULL;
    }
}

static int32_t parse_set(ss_world *world, const char *argument, ss_command_record *record,
                         char *out_text, int32_t text_size)
{
    ss_scene_model models[SS_MAX_MODELS];
    ss_world_scene_models(models);
    softsim_error error = {0};
    if (ss_scene_parse_live(argument, &models[world->scene->model_index], &record->key,
                            &record->row, &record->value, &error) != SOFTSIM_OK) {
        snprintf(out_text, (size_t)text_size, "%.*s", (int)text_size - 1, error.text);
        return 2;
    }
    if (record->key == SS_LIVE_MESH_RATE && (!world->surface || record->value <= 0.0)) {
        snprintf(out_text, (size_t)text_size,
                 "publish.mesh_rate_hz: starting or ending the mesh publisher needs a restart");
        return 1;
    }
    if (record->key == SS_LIVE_FIELD && !world->surface) {
        snprintf(out_text, (size_t)text_size,
                 "publish.field: no mesh is published (publish.mesh_rate_hz is 0)");
        return 1;
    }
    if (record->key == SS_LIVE_FIELD &&
        !ss_field_is_possible(world->scene, world->model_class, (ss_scene_field)record->value)) {
        char possible[128];
        ss_field_list(world->scene, world->model_class, " or ", possible, sizeof possible);
        snprintf(out_text, (size_t)text_size, "publish.field: this body has %s; use %s",
                 ss_field_lack((ss_scene_field)record->value), possible);
        return 1;
    }
    double most = INFINITY;
    const char *name = felt_limit(world->scene, record->key, &most);
    if (record->value > most) {
        snprintf(out_text, (size_t)text_size,
                 "refused: no command raises %s above the scene's %g, for what the hand feels is "
                 "decided where the scene is; start the server with another --set",
                 name, most);
        return 1;
    }
    return 0;
}

static int32_t slot_of(ss_scene_live_key key, int32_t row)
{
    return key == SS_LIVE_MODEL_ROW ? SS_LIVE_MODEL_ROW + row : (int32_t)key;
}

/* Says what is set now and was before, and remembers it. */
static void tell_set(ss_world *world, const char *argument, const ss_command_record *record,
                     char *out_text, int32_t text_size)
{
    ss_scene_model models[SS_MAX_MODELS];
    ss_world_scene_models(models);
    ss_set_value *set = &world->set_value[slot_of(record->key, record->row)];
    ss_scene_tell_live(world->scene, &models[world->scene->model_index], argument, record->value,
                       set->is_set ? &set->value : NULL, out_text, (size_t)text_size);
    *set = (ss_set_value){.is_set = true, .value = record->value};
    if (record->key == SS_LIVE_COUPLING_STIFFNESS) {
        const size_t length = strlen(out_text);
        snprintf(out_text + length, (size_t)text_size - length,
                 "; the hand's limit moves there by 20 %% a second, as far as the loop's delay "
                 "allows: stiffness_limit_n_per_m of the status");
    }
}

bool ss_world_describe_live(const ss_world *world, int32_t number, char *out, size_t size)
{
    ss_scene_model models[SS_MAX_MODELS];
    ss_world_scene_models(models);
    const ss_scene_model *model = &models[world->scene->model_index];
    ss_scene_live live;
    if (!ss_scene_find_live(model, number, &live)) {
        return false;
    }
    double most = INFINITY;
    (void)felt_limit(world->scene, live.key, &most);
    const ss_set_value *set = &world->set_value[slot_of(live.key, live.row)];
    if (live.key == SS_LIVE_FIELD) { /* of its choices those that this body has */
        char possible[128];
        ss_field_list(world->scene, world->model_class, "|", possible, sizeof possible);
        snprintf(out, size, "%s=%s 0 %d %s", live.path,
                 ss_field_name(set->is_set ? (ss_scene_field)set->value : world->scene->field),
                 SS_SCENE_FIELD_POTENTIAL, possible);
        return true;
    }
    ss_scene_describe_live(world->scene, model, &live, set->is_set ? &set->value : NULL, most, out,
                           size);
    return true;
}

int32_t ss_world_command(ss_world *world, const char *name, const char *argument,
                         ss_command_record *out_record, char *out_text, int32_t text_size)
{
    static const char *const names[] = {"reset", "pause",  "resume",  "refresh",
                                        "set",   "status", "shutdown"};
    static const char *const did[] = {
        "reset: the body is at rest, without a force, and a fault is forgotten",
        "paused: the body stands still and forces are zero until the command resume",
        "running again",
        "the whole mesh is being sent again",
        "",
        "a status is on its way",
        "shutting down"};
    const int32_t name_count = (int32_t)(sizeof names / sizeof *names);
    int32_t kind = 0;
    while (kind < name_count && strcmp(names[kind], name) != 0) {
        ++kind;
    }
    if (kind == name_count) {
        snprintf(out_text, (size_t)text_size,
                 "unknown command '%.40s'; use reset pause resume refresh set status shutdown",
                 name);
        return 2;
    }
    if (kind != SS_COMMAND_SET && argument[0] != '\0') {
        snprintf(out_text, (size_t)text_size,
                 "%s takes no argument, but '%.40s' came; leave it out", name, argument);
        return 2;
    }
    *out_record = (ss_command_record){.kind = (ss_command_kind)kind};
    snprintf(out_text, (size_t)text_size, "%s", did[kind]);
    if (kind == SS_COMMAND_SET) {
        const int32_t code = parse_set(world, argument, out_record, out_text, text_size);
        if (code != 0) {
            return code;
        }
    }
    if (kind == SS_COMMAND_REFRESH || kind == SS_COMMAND_STATUS || kind == SS_COMMAND_SHUTDOWN) {
        return 0;
    }
    /* All who are concerned take it, or none. The loops count resets, each for itself. Without
     * tools there is no haptic loop. */
    const bool is_felt = world->used_probes != 0;
    if (!ss_ring_has_room(world->simulation_commands) ||
        (is_felt && !ss_ring_has_room(world->haptic_commands))) {
        snprintf(out_text, (size_t)text_size, "busy: too many commands at once; send it again");
        return 1;
    }
    ss_ring_push(world->simulation_commands, out_record);
    if (is_felt) {
        ss_ring_push(world->haptic_commands, out_record);
    }
    if (kind == SS_COMMAND_SET) {
        if (out_record->key == SS_LIVE_MAX_JUMP) {
            ss_gate_set_max_jump(world->gate, out_record->value);
        }
        tell_set(world, argument, out_record, out_text, text_size);
    }
    return 0;
}
