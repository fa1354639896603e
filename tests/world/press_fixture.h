/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Bodies of every model to press, in headless worlds. cmocka comes first. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/folder_fixture.h"
#include "common/kidney.h"
#include "world_fixture.h"

/* ---- bodies ---- */

typedef struct body {
    const char *name;
    const char *scene;     /* of server/scenes, or NULL: the block with this model */
    const char *model;     /* yaml of the block's model */
    const char *set;       /* one more value, or NULL */
    double touch[3];       /* m, where the tool just touches */
    double in[3], side[3]; /* unit: into the tissue, along it */
    double depth;          /* m, of the press */
} body;

/* Where a tool touches, the way in, and the way along. */
#define AT(x, y, z, a, b, c, d, e, f)                                                              \
    {x, y, z}, {a, b, c},                                                                          \
    {                                                                                              \
        d, e, f                                                                                    \
    }
#define ON_BLOCK     AT(0, 0, 0.028, 0, 0, -1, 1, 0, 0)
#define ON_KIDNEY    AT(0, 0.006, 0.0273, 0, 0, -1, 1, 0, 0)
#define ON_VENTRICLE AT(0.040, 0, -0.01, -1, 0, 0, 0, 1, 0)
#define ON_LIVER     AT(-0.035, 0, 0.050, 0, 0, -1, 1, 0, 0)
#define ON_HM1       AT(0.0385, 0, -0.005, -1, 0, 0, 0, 1, 0)
#define ELASTIC                                                                                    \
    "  youngs_modulus_pa: 60000\n  poisson_ratio: 0.4\n  density_kg_m3: 1060\n"                    \
    "  mass_damping_per_s: 30\n"

static const body bodies[] = {
    {"kidney", "kidney.yaml", NULL, NULL, ON_KIDNEY, 0.020},
    {"hard kidney", "kidney.yaml", NULL, "model.rest_stiffness_n_per_m3=200000", ON_KIDNEY, 0.020},
    {"ventricle", "ventricle.yaml", NULL, NULL, ON_VENTRICLE, 0.016},
    {"hard ventricle", "ventricle.yaml", NULL, "model.youngs_modulus_pa=200000", ON_VENTRICLE,
     0.030},
    {"liver", "liver-chainmail.yaml", NULL, NULL, ON_LIVER, 0.020},
    {"hard liver", "liver-chainmail.yaml", NULL, "model.link_stiffness_n_per_m=900", ON_LIVER,
     0.024},
    {"hm1", "hm1-tissue.yaml", NULL, NULL, ON_HM1, 0.016},
    {"hard hm1", "hm1-tissue.yaml", NULL, "model.youngs_modulus_pa=200000", ON_HM1, 0.014},
    {"xpbd", NULL, "  name: xpbd\n" ELASTIC, NULL, ON_BLOCK, 0.012},
    {"hard xpbd", NULL, "  name: xpbd\n" ELASTIC, "model.youngs_modulus_pa=300000", ON_BLOCK,
     0.024},
    {"corotational", NULL, "  name: corotational\n" ELASTIC, NULL, ON_BLOCK, 0.010},
    {"mass-spring", NULL,
     "  name: mass-spring\n  youngs_modulus_pa: 60000\n  density_kg_m3: 1060\n"
     "  mass_damping_per_s: 30\n",
     NULL, ON_BLOCK, 0.006},
    {"hard mass-spring", NULL,
     "  name: mass-spring\n  youngs_modulus_pa: 400000\n  density_kg_m3: 1060\n"
     "  mass_damping_per_s: 30\n",
     NULL, ON_BLOCK, 0.006},
    {"chainmail", NULL, "  name: chainmail\n  alpha: 0.05\n  beta: 0.05\n", NULL, ON_BLOCK, 0.012},
};
enum { BODIES = sizeof bodies / sizeof *bodies };

/* Cells of six tetrahedra over x and y of -size/2 .. size/2 and z of 0 .. size[2], mm. */
static inline int box_node(const int cells[3], const int at[3])
{
    return (at[2] * (cells[1] + 1) + at[1]) * (cells[0] + 1) + at[0] + 1;
}

/* Is a node (`width` 0) or a cell (1) within `hollow` cells about the middle? */
static inline bool is_within(const int cells[3], const int at[3], int width, int hollow)
{
    bool is_in = true;
    for (int a = 0; a < 3; ++a) {
        is_in = is_in && abs(2 * at[a] + width - cells[a]) < hollow;
    }
    return is_in;
}

/* `hollow` cells are left out all around the middle; 0: none. */
static inline void write_hollow_mesh(const int cells[3], const double size[3], int hollow)
{
    static const int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                    {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    static const bool is_odd[6] = {false, true, true, false, false, true};
    FILE *file = open_file("block.msh");
    const int missing = hollow > 1 ? (hollow - 1) * (hollow - 1) * (hollow - 1) : 0;
    fprintf(file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n",
            (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1) - missing);
    for (int k = 0; k <= cells[2]; ++k) {
        for (int j = 0; j <= cells[1]; ++j) {
            for (int i = 0; i <= cells[0]; ++i) {
                const int at[3] = {i, j, k};
                if (is_within(cells, at, 0, hollow)) {
                    continue;
                }
                fprintf(file, "%d %.9g %.9g %.9g\n", box_node(cells, at),
                        size[0] * i / cells[0] - 0.5 * size[0],
                        size[1] * j / cells[1] - 0.5 * size[1], size[2] * k / cells[2]);
            }
        }
    }
    const int count = cells[0] * cells[1] * cells[2];
    fprintf(file, "$EndNodes\n$Elements\n%d\n", 6 * (count - hollow * hollow * hollow));
    int element = 0;
    for (int cell = 0; cell < count; ++cell) {
        const int place[3] = {cell % cells[0], cell / cells[0] % cells[1],
                              cell / (cells[0] * cells[1])};
        for (int p = 0; p < (is_within(cells, place, 1, hollow) ? 0 : 6); ++p) {
            int at[3] = {place[0], place[1], place[2]};
            int node[4] = {box_node(cells, at)};
            for (int s = 0; s < 3; ++s) {
                ++at[order[p][s]];
                node[s + 1] = box_node(cells, at);
            }
            fprintf(file, "%d 4 2 1 1 %d %d %d %d\n", ++element, node[0], node[is_odd[p] ? 2 : 1],
                    node[is_odd[p] ? 1 : 2], node[3]);
        }
    }
    fprintf(file, "$EndElements\n");
    assert_int_equal(fclose(file), 0);
}

static inline void write_box_mesh(const int cells[3], const double size[3])
{
    write_hollow_mesh(cells, size, 0);
}

/* Held below. */
static inline void write_block_mesh(void)
{
    static const int cells[3] = {8, 8, 4};
    static const double size[3] = {60.0, 60.0, 20.0};
    write_box_mesh(cells, size);
}

static inline const char *write_block(const body *b)
{
    char text[1024];
    (void)snprintf(text, sizeof text,
                   "softsim: 1\n"
                   "object:\n  mesh: block.msh\n  units: mm\n"
                   "  fixed: [{box_m: [[-1, -1, -1], [1, 1, 0.0001]]}]\n"
                   "model:\n%s"
                   "contact:\n  tools: [{probe: 0, shape: {sphere: {radius_mm: 8}}}]\n"
                   "  working_force_n: 2\n",
                   b->model);
    return write_text(b->name, text);
}

/* The world of a body's bundled scene, or of the block; values as --set takes them. */
static inline softsim_world *open_body(const body *b, const char *const *set, int32_t count)
{
    char path[512];
    (void)snprintf(path, sizeof path, SOURCE_DIR "/server/scenes/%s", b->scene ? b->scene : "");
    return open_scene(b->scene ? path : write_block(b), set, count);
}

static inline int make_folder_with_block(void **state)
{
    const int result = make_folder(state);
    write_block_mesh();
    return result;
}

/* `chainmail` refuses a scene with that value, and says `words`. */
static inline void expect_chainmail_refuses(const char *set, const char *words)
{
    static const body mail = {
        "chainmail", NULL, "  name: chainmail\n  alpha: 0.05\n  beta: 0.05\n", NULL, ON_BLOCK, 0.0};
    softsim_config config = softsim_default_config();
    softsim_error error = {0};
    config.set = &set;
    config.set_count = 1;
    assert_null(softsim_create(write_block(&mail), &config, &error));
    assert_non_null(strstr(error.text, words));
    assert_int_equal(error.fault_count, 1);
}

/* `mesh` is the kidney's, as --set takes it. */
static inline softsim_world *make_world_on(const body *b, double limit, const char *mesh)
{
    char force[64];
    (void)snprintf(force, sizeof force, "haptic.max_force_n=%g", limit);
    const bool is_kidney = b->scene && strcmp(b->scene, "kidney.yaml") == 0;
    const char *set[3] = {force};
    int32_t count = 1;
    if (b->set) {
        set[count++] = b->set;
    }
    if (is_kidney) {
        set[count++] = mesh;
    }
    return open_body(b, set, count);
}

static inline softsim_world *make_world(const body *b, double limit)
{
    return make_world_on(b, limit, kidney_mesh());
}

/* The bundled scene as it is, where what is claimed depends on the mesh. */
static inline softsim_world *make_bundled_world(const body *b, double limit)
{
    return make_world_on(b, limit, "object.mesh=" KIDNEY_MESH);
}

static inline double smooth(double u)
{
    u = fmin(1.0, fmax(0.0, u));
    return u * u * u * (10.0 - u * (15.0 - 6.0 * u));
}

static inline softsim_pose pose_of(int32_t seq, const double position[3])
{
    softsim_pose pose = {.sender = 7, .seq = seq, .force_seq = -1, .orientation = {1, 0, 0, 0}};
    for (int a = 0; a < 3; ++a) {
        pose.position[a] = position[a];
        pose.velocity[a] = pose.applied_force[a] = (double)NAN;
    }
    return pose;
}

/* In contact is what has contacts, and nothing else has a force, a torque or a depth. */
static inline void assert_consistent(const softsim_force *force)
{
    const bool is_contact = (force->flags & SOFTSIM_FORCE_CONTACT) != 0;
    assert_int_equal(force->contact_count > 0, is_contact);
    for (int a = 0; a < 3; ++a) {
        assert_true(is_contact || (fabs(force->force[a]) <= 0.0 && fabs(force->torque[a]) <= 0.0));
    }
    assert_true(force->depth >= 0.0 && (is_contact || force->depth <= 0.0));
}

static inline softsim_force feel(softsim_world *world, const softsim_pose *pose)
{
    softsim_force force[SOFTSIM_MAX_PROBES];
    const int32_t channel = 0;
    (void)softsim_tick(world, pose, &channel, 1, force);
    assert_consistent(&force[0]);
    return force[0];
}
