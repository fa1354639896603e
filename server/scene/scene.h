/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A YAML scene to a validated description: everything the world needs to plan, nothing built yet.
 *
 * In: a file, `--set PATH=VALUE` overrides, the table of model parameters (handed in, so that
 * scene/ knows no model). Out: SI values and node sets resolved on the loaded mesh. Every fault
 * of a file is reported in one go as file:line:col with the line and a caret. Keys are read
 * through a table of rows (key, unit, bounds, help); unknown keys are faults.
 * Thread: set-up only.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "contact/contact.h"
#include "mesh/mesh.h"
#include "rt/files.h"
#include "rt/param.h"
#include "softsim/types.h"

/* What the scene needs to know of a model. */
typedef struct ss_scene_model {
    const char *name;
    const ss_param_row *row;
    int32_t row_count;
    bool needs_volume, takes_second_order;
} ss_scene_model;

/* What a list of values by region says that may not be meant: of an entry that gives its value to
 * nothing (is_unused), or to less than it takes, since earlier ones took that. */
enum { SS_SCENE_MAX_DOUBTS = 32 }; /* more are left out */
typedef struct ss_scene_doubt {
    bool is_unused;
    char where[96]; /* "model.rho.1" */
    char text[160];
} ss_scene_doubt;

/* One entry of `prescribed` gives several of these when its displacement_file leaves different
 * axes free at different nodes: they share `entry` and `name`. */
typedef struct ss_scene_prescribed {
    int32_t *node;
    int32_t node_count;
    double (*displacement)[3];
    bool axis[3];
    double from, ramp;
    char name[64]; /* the group's, else prescribed.N */
    int32_t entry; /* number in the scene's list, from 0 */
} ss_scene_prescribed;

typedef struct ss_scene_tool {
    bool is_used;
    ss_shape shape;
} ss_scene_tool;

/* Is a body at rest stepped? */
typedef enum ss_scene_sleep { SS_SCENE_SLEEP_AUTO, SS_SCENE_SLEEP_OFF } ss_scene_sleep;

typedef enum ss_scene_between { SS_SCENE_HOLD, SS_SCENE_LINEAR, SS_SCENE_LOCAL } ss_scene_between;

/* What the surface's nodes are coloured by on the wire. */
#define SS_SCENE_FIELD_CHOICES "none|displacement|energy|pressure|potential"
typedef enum ss_scene_field {
    SS_SCENE_FIELD_NONE,
    SS_SCENE_FIELD_DISPLACEMENT,
    SS_SCENE_FIELD_ENERGY,
    SS_SCENE_FIELD_PRESSURE,
    SS_SCENE_FIELD_POTENTIAL
} ss_scene_field;

typedef struct ss_scene {
    char path[1024];
    char model_name[64];
    int32_t model_index;   /* into the table handed in */
    ss_mesh *mesh;         /* loaded, transformed, accepted */
    ss_mesh *surface;      /* a finer one that sides follow, the same; NULL: none */
    uint8_t *fixed;        /* node_count: bit 0 x, 1 y, 2 z */
    ss_param_value *param; /* in the model's row order */
    ss_load *load;
    int32_t load_count;
    ss_scene_prescribed *prescribed;
    int32_t prescribed_count;
    ss_scene_tool tool[SOFTSIM_MAX_PROBES];
    ss_param_value friction; /* by node where it varies */
    double working_force_n;
    double contact_stiffness_n_per_m3; /* 0: chosen from the working force */
    double grasp_max_force_n;          /* NaN: no grasp is torn */
    double simulation_rate_hz;         /* 0: auto */
    int32_t max_substeps;
    ss_scene_sleep sleep;
    double gravity[3];
    ss_scene_between between_steps;
    double haptic_rate_hz, max_force_n, max_slew_n_per_s, coupling_stiffness_n_per_m,
        coupling_damping_n_s_per_m, max_jump_m;
    double mesh_rate_hz; /* 0: no mesh publisher */
    double max_bytes_per_s;
    ss_scene_field field;
    ss_scene_doubt doubt[SS_SCENE_MAX_DOUBTS];
    int32_t doubt_count;
    ss_mesh_repairs repairs;        /* by `object.repair: true` */
    struct ss_scene_source *source; /* what was written, for ss_scene_print */
} ss_scene;

/* `overrides`: `path.to.key=value` strings. `import_program` as for ss_mesh_load. On failure every
 * fault is in `error` and *out_scene is NULL. */
softsim_status ss_scene_load(const char *path, const char *const *overrides, int32_t override_count,
                             const ss_scene_model *models, int32_t model_count,
                             const char *import_program, ss_scene **out_scene,
                             softsim_error *error);
/* The same from memory; `path` names the text in messages and is where its files are looked for. */
softsim_status ss_scene_load_text(const char *path, const char *text, size_t size,
                                  const char *const *overrides, int32_t override_count,
                                  const ss_scene_model *models, int32_t model_count,
                                  const char *import_program, ss_scene **out_scene,
                                  softsim_error *error);
void ss_scene_destroy(ss_scene **scene);

/* Numbers nodes and elements of a loaded scene by place (ss_mesh_renumber), and with them all that
 * is kept by number here: a world's memory. What a user reads or writes stays in the file's
 * numbers, by the mesh's file_node and file_element. Once. False when out of memory. */
bool ss_scene_renumber(ss_scene *scene);

/* Effective values as YAML, each with its unit, range, default and whether `set` reaches it. */
void ss_scene_print(const ss_scene *scene, const ss_scene_model *model,
                    void (*line)(void *sink, const char *text), void *sink);

/* What was given under a key of the scene ("model"), overrides included: a line for each key, two
 * spaces in, file names absolute. */
void ss_scene_print_given(const ss_scene *scene, const char *key,
                          void (*line)(void *sink, const char *text), void *sink);

/* The number at a path ("model.rho", "model.rho.0.value"): as written, overrides included, or a
 * model parameter's default. False where there is none, or no number. */
bool ss_scene_find_number(const ss_scene *scene, const ss_scene_model *model, const char *path,
                          double *out_value);

/* Adds a fault for the first output that is a file which the scene names, overrides included, or
 * another output (ss_files_check); true without one. */
bool ss_scene_check_outputs(const ss_scene *scene, const ss_named_file *output,
                            int32_t output_count, softsim_error *error);

/* The scene's file with values put in their places, for a file in another folder perhaps: all else
 * stays as it was written, comments too, but that file names become absolute when the folder is
 * another. `assignments` as overrides: what is there is replaced, and told as a comment at the
 * end of its line ("# was 5"), what is not is added. Of the
 * overrides that the scene was loaded with, those to be kept must be among them. The text is to be
 * freed; NULL with the faults in `error`, also where a value cannot be placed. */
char *ss_scene_rewrite(const ss_scene *scene, const char *const *assignments, int32_t count,
                       const char *folder, softsim_error *error);

/* For the command `set`: parses PATH=VALUE for the live keys (haptic.*, publish.*, model rows with
 * is_live). On success *out_key is the key and *out_value the value. */
typedef enum ss_scene_live_key {
    SS_LIVE_MAX_FORCE,
    SS_LIVE_MAX_SLEW,
    SS_LIVE_COUPLING_STIFFNESS,
    SS_LIVE_COUPLING_DAMPING,
    SS_LIVE_BETWEEN_STEPS,
    SS_LIVE_MAX_JUMP,
    SS_LIVE_MESH_RATE,
    SS_LIVE_MAX_BYTES,
    SS_LIVE_FIELD,
    SS_LIVE_MODEL_ROW
} ss_scene_live_key;
softsim_status ss_scene_parse_live(const char *assignment, const ss_scene_model *model,
                                   ss_scene_live_key *out_key, int32_t *out_row, double *out_value,
                                   softsim_error *error);
/* What an assignment that ss_scene_parse_live has taken changes, in words: "haptic.max_force_n = 5
 * N (was 8)". `before`: the value that is replaced; NULL: the scene's own. */
void ss_scene_tell_live(const ss_scene *scene, const ss_scene_model *model, const char *assignment,
                        double value, const double *before, char *out, size_t size);
/* One of the live keys, for who lists them. */
typedef struct ss_scene_live {
    char path[128];
    ss_scene_live_key key;
    int32_t row; /* of the model's table, for SS_LIVE_MODEL_ROW; else -1 */
} ss_scene_live;
/* Number 0, 1, ... of them, the model's last; false beyond. */
bool ss_scene_find_live(const ss_scene_model *model, int32_t number, ss_scene_live *out_live);
/* "PATH=VALUE LOW HIGH UNIT", HIGH at most `most`; of a choice LOW and HIGH are the numbers of its
 * first and last word and UNIT is its words, "hold|linear|local"; VALUE is "varies" where nodes
 * have values of their own. `set`: what it was set to; NULL: the scene's own. */
void ss_scene_describe_live(const ss_scene *scene, const ss_scene_model *model,
                            const ss_scene_live *live, const double *set, double most, char *out,
                            size_t size);
