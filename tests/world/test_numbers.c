/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Numbers by place: what ss_mesh_renumber and ss_scene_renumber do, and that a user never sees it.
 * Files are shuffled at random, so that every map must be right for a test to pass.
 */
#include "common/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/folder_fixture.h"
#include "rt/each.h"
#include "rt/hash.h"
#include "rt/random.h"
#include "rt/vec.h"
#include "softsim/softsim.h"
#include "world/world.h"

static softsim_error error;

enum { BLOCK = 64 };

/* ---- shuffled meshes ---- */

/* A random order of 0 .. count - 1. */
static int32_t *shuffle(int32_t count, uint64_t seed)
{
    int32_t *order = malloc((size_t)count * sizeof *order);
    assert_non_null(order);
    for (int32_t i = 0; i < count; ++i) {
        order[i] = i;
    }
    for (int32_t i = count - 1; i > 0; --i) {
        const int32_t other = (int32_t)ss_random_below(&seed, (uint32_t)i + 1);
        const int32_t kept = order[i];
        order[i] = order[other];
        order[other] = kept;
    }
    return order;
}

typedef enum kind { TRIANGLES, QUADS, TETRAHEDRA } kind;

/* A bent grid of 21 x 16 nodes (what: quads, or halves for scatter()), or a block of 9 x 8 x 7
 * nodes in tetrahedra. */
static ss_mesh *make(kind what)
{
    ss_mesh *m = NULL;
    if (what != TETRAHEDRA) {
        assert_int_equal(ss_mesh_create_plane(21, 16, 0.15, 0.2, &m, &error), SOFTSIM_OK);
        for (int32_t i = 0; i < m->node_count; ++i) {
            double *x = m->position[i];
            x[2] = 2.0 * x[0] * x[0] - x[1] * x[0];
        }
        return m;
    }
    enum { NX = 9, NY = 8, NZ = 7 };
    static const int corner[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                     {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
    static double x[NX * NY * NZ][3];
    static int32_t tetrahedron[6 * (NX - 1) * (NY - 1) * (NZ - 1)][4];
    int32_t count = 0;
    for (int i = 0; i < NX * NY * NZ; ++i) {
        ss_set3(x[i], 0.01 * (i % NX), 0.01 * (i / NX % NY), 0.01 * (i / NX / NY));
        const int c[3] = {i % NX, i / NX % NY, i / NX / NY};
        for (int t = 0; t < 6 && c[0] < NX - 1 && c[1] < NY - 1 && c[2] < NZ - 1; ++t) {
            for (int k = 0; k < 4; ++k) {
                const int b = corner[t][k];
                tetrahedron[count][k] = i + (b & 1) + NX * (b >> 1 & 1) + NX * NY * (b >> 2);
            }
            ++count;
        }
    }
    assert_int_equal(ss_mesh_create(NX * NY * NZ, (const double(*)[3])x, 0, NULL, count,
                                    (const int32_t(*)[4])tetrahedron, &m, &error),
                     SOFTSIM_OK);
    return m;
}

/* Nodes and elements of `m` in random order. */
static ss_mesh *scatter(const ss_mesh *m, kind what)
{
    const int32_t elements = what == TRIANGLES ? m->triangle_count : ss_mesh_element_count(m);
    const int size = what == TRIANGLES ? 3 : 4;
    const int32_t *element = what == TRIANGLES ? (const int32_t *)m->triangle
                             : what == QUADS   ? (const int32_t *)m->quad
                                               : (const int32_t *)m->tetrahedron;
    int32_t *node_place = shuffle(m->node_count, 5);
    int32_t *place = shuffle(elements, 6);
    double(*x)[3] = calloc((size_t)m->node_count, sizeof *x);
    int32_t *node = calloc((size_t)(elements * size), sizeof *node);
    for (int32_t i = 0; i < m->node_count; ++i) {
        ss_copy3(x[node_place[i]], m->position[i]);
    }
    for (int32_t e = 0; e < elements; ++e) {
        for (int k = 0; k < size; ++k) {
            node[size * place[e] + k] = node_place[element[size * e + k]];
        }
    }
    ss_mesh *out = NULL;
    const double(*position)[3] = (const double(*)[3])x;
    const softsim_status status =
        what == TRIANGLES ? ss_mesh_create(m->node_count, position, elements,
                                           (const int32_t(*)[3])node, 0, NULL, &out, &error)
        : what == QUADS   ? ss_mesh_create_quads(m->node_count, position, elements,
                                                 (const int32_t(*)[4])node, &out, &error)
                          : ss_mesh_create(m->node_count, position, 0, NULL, elements,
                                           (const int32_t(*)[4])node, &out, &error);
    assert_int_equal(status, SOFTSIM_OK);
    SS_EACH(free, node_place, place, x, node);
    return out;
}

static ss_mesh *make_scattered(kind what)
{
    ss_mesh *m = make(what);
    ss_mesh *scattered = scatter(m, what);
    ss_mesh_destroy(&m);
    return scattered;
}

/* Nodes outside a block of 64 that share an element with it, mean over the blocks. */
static double external_nodes(const ss_mesh *m)
{
    const int size = m->tetrahedron_count > 0 || m->quad_count > 0 ? 4 : 3;
    const int32_t *element = m->tetrahedron_count > 0 ? (const int32_t *)m->tetrahedron
                             : m->quad_count > 0      ? (const int32_t *)m->quad
                                                      : (const int32_t *)m->triangle;
    const int32_t blocks = (m->node_count + BLOCK - 1) / BLOCK;
    bool *is_external = calloc((size_t)blocks * (size_t)m->node_count, 1);
    int64_t count = 0;
    for (int32_t e = 0; e < ss_mesh_element_count(m); ++e) {
        for (int i = 0; i < size * size; ++i) {
            const int32_t block = element[size * e + i / size] / BLOCK;
            const int32_t other = element[size * e + i % size];
            if (other / BLOCK != block && !is_external[block * m->node_count + other]) {
                is_external[block * m->node_count + other] = true;
                ++count;
            }
        }
    }
    free(is_external);
    return (double)count / blocks;
}

/* ---- the mesh ---- */

static void the_same_element(const int32_t *a, const int32_t *b, int size, const int32_t *file_node)
{
    for (int k = 0; k < size; ++k) {
        assert_int_equal(file_node[a[k]], b[k]);
    }
}

TEST(every_number_leads_back_to_the_file)
{
    for (kind what = TRIANGLES; what <= TETRAHEDRA; ++what) {
        ss_mesh *m = make_scattered(what);
        ss_mesh *file = make_scattered(what);
        assert_true(ss_mesh_renumber(m));
        assert_non_null(m->file_node);
        assert_non_null(m->file_element);
        int32_t *seen = calloc((size_t)m->node_count, sizeof *seen);
        for (int32_t i = 0; i < m->node_count; ++i) {
            ++seen[m->file_node[i]];
            assert_memory_equal(m->position[i], file->position[m->file_node[i]], 24);
        }
        for (int32_t i = 0; i < m->node_count; ++i) {
            assert_int_equal(seen[i], 1);
        }
        free(seen);
        for (int32_t e = 0; e < ss_mesh_element_count(m); ++e) {
            const int32_t f = m->file_element[e];
            if (what == TRIANGLES) {
                the_same_element(m->triangle[e], file->triangle[f], 3, m->file_node);
            } else if (what == QUADS) {
                the_same_element(m->quad[e], file->quad[f], 4, m->file_node);
                the_same_element(m->triangle[2 * e], file->triangle[2 * f], 3, m->file_node);
                the_same_element(m->triangle[2 * e + 1], file->triangle[2 * f + 1], 3,
                                 m->file_node);
            } else {
                the_same_element(m->tetrahedron[e], file->tetrahedron[f], 4, m->file_node);
            }
        }
        ss_mesh_report r;
        ss_mesh_report s;
        assert_int_equal(ss_mesh_accept(m, "renumbered", &error), SOFTSIM_OK);
        (void)ss_mesh_check(m, &r);
        (void)ss_mesh_check(file, &s);
        assert_true(fabs(r.area - s.area) < 1e-12);
        assert_true(!m->is_closed || fabs(r.volume - s.volume) < 1e-12);
        assert_int_equal(r.mixed_direction.count, s.mixed_direction.count);
        ss_mesh_destroy(&m);
        ss_mesh_destroy(&file);
    }
}

TEST(blocks_have_few_neighbours_outside)
{
    /* A square patch of 64 nodes of a grid has 36 about it, a cube of 64 in tetrahedra some 110;
     * the rim has fewer. */
    static const double most[3] = {33.0, 36.0, 85.0};
    for (kind what = TRIANGLES; what <= TETRAHEDRA; ++what) {
        ss_mesh *m = make_scattered(what);
        const double before = external_nodes(m);
        assert_true(ss_mesh_renumber(m));
        const double after = external_nodes(m);
        print_message("nodes outside a block of 64: %.1f, scattered %.1f\n", after, before);
        assert_true(after < most[what]);
        assert_true(after < 0.5 * before);
        ss_mesh_destroy(&m);
    }
}

TEST(numbers_that_are_right_already_have_no_map)
{
    for (kind what = TRIANGLES; what <= TETRAHEDRA; ++what) {
        ss_mesh *m = make_scattered(what);
        assert_true(ss_mesh_renumber(m));
        ss_mesh *again = NULL;
        const double(*x)[3] = (const double(*)[3])m->position;
        assert_int_equal(
            what == QUADS
                ? ss_mesh_create_quads(m->node_count, x, m->quad_count,
                                       (const int32_t(*)[4])m->quad, &again, &error)
                : ss_mesh_create(m->node_count, x, what == TRIANGLES ? m->triangle_count : 0,
                                 (const int32_t(*)[3])m->triangle, m->tetrahedron_count,
                                 (const int32_t(*)[4])m->tetrahedron, &again, &error),
            SOFTSIM_OK);
        assert_true(ss_mesh_renumber(again));
        assert_null(again->file_node);
        assert_null(again->file_element);
        assert_int_equal(ss_mesh_file_node(again, 7), 7);
        assert_int_equal(ss_mesh_file_element(again, 7), 7);
        ss_mesh_destroy(&m);
        ss_mesh_destroy(&again);
    }
}

/* ---- the scene ---- */

/* `file` as MSH with the group `even` of every other node, a value rho = 1 + number / 1000 and a
 * direction (number, 1, 0). */
static void write_files(const char *name, const ss_mesh *mesh)
{
    char text[64];
    FILE *file = open_file(name);
    const int size = mesh->quad_count > 0 ? 4 : 3;
    const int32_t elements = ss_mesh_element_count(mesh);
    const int32_t *node = mesh->quad_count > 0 ? mesh->quad[0] : mesh->triangle[0];
    fprintf(file,
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n0 1 \"even\"\n"
            "$EndPhysicalNames\n$Nodes\n%d\n",
            mesh->node_count);
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        fprintf(file, "%d %.17g %.17g %.17g\n", i + 1, mesh->position[i][0], mesh->position[i][1],
                mesh->position[i][2]);
    }
    fprintf(file, "$EndNodes\n$Elements\n%d\n", elements + (mesh->node_count + 1) / 2);
    for (int32_t i = 0; i < mesh->node_count; i += 2) {
        fprintf(file, "%d 15 2 1 0 %d\n", i + 1, i + 1);
    }
    for (int32_t e = 0; e < elements; ++e) {
        fprintf(file, "%d %d 2 0 0", e + 1, size - 1);
        for (int k = 0; k < size; ++k) {
            fprintf(file, " %d", node[size * e + k] + 1);
        }
        fprintf(file, "\n");
    }
    fprintf(file, "$EndElements\n");
    fclose(file);
    snprintf(text, sizeof text, "%s.rho.csv", name);
    file = open_file(text);
    fprintf(file, "node,value\n");
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        fprintf(file, "%d,%.17g\n", i, 1.0 + 1e-3 * i);
    }
    fclose(file);
    snprintf(text, sizeof text, "%s.grain.csv", name);
    file = open_file(text);
    fprintf(file, "element,x,y,z\n");
    for (int32_t e = 0; e < elements; ++e) {
        fprintf(file, "%d,%d,1,0\n", e, e);
    }
    fclose(file);
    snprintf(text, sizeof text, "%s.stiff.csv", name);
    file = open_file(text);
    fprintf(file, "element,value\n");
    for (int32_t e = elements - 1; e >= 0; --e) {
        fprintf(file, "%d,%.17g\n", e, 2.0 + 1e-3 * e);
    }
    fclose(file);
    snprintf(text, sizeof text, "%s.lift.csv", name);
    file = open_file(text);
    fprintf(file, "node,ux,uy,uz\n");
    for (int32_t i = 20; i < 26; ++i) {
        fprintf(file, "%d,,,%.17g\n", i, 1e-5 * i);
    }
    fclose(file);
}

static const ss_param_row jelly_row[] = {
    SS_PARAM(FIELD, "rho", "conductance", SS_FROM(0, 10), .fallback = 1),
    SS_PARAM(DIRECTION, "grain", "of the fibres"),
    SS_PARAM(FIELD, "stiff", "stiffness", SS_FROM(0, 10), .takes_elements = true, .fallback = 1),
};
static const ss_scene_model jelly = {.name = "jelly", .row = jelly_row, .row_count = 3};

TEST(a_scene_is_renumbered_with_its_mesh)
{
    for (kind what = TRIANGLES; what <= QUADS; ++what) {
        ss_mesh *mesh = make_scattered(what);
        write_files("s.msh", mesh);
        ss_mesh_destroy(&mesh);
        static const char text[] =
            "softsim: 1\nobject: {mesh: s.msh, units: m, fixed: [{nodes: [3, 5, 8]}, {group: even, "
            "axes: y}]}\n"
            "model: {name: jelly, rho: {file: s.msh.rho.csv}, grain: {file: s.msh.grain.csv}, "
            "stiff: {file: s.msh.stiff.csv}}\n"
            "loads: [{nodes: [100, 7, 31], force_n: [0, 0, 1]}]\n"
            "prescribed: [{displacement_file: s.msh.lift.csv}]\n";
        ss_scene *s = NULL;
        error = (softsim_error){0};
        if (ss_scene_load_text(in_folder("s.yaml"), text, sizeof text - 1, NULL, 0, &jelly, 1, NULL,
                               &s, &error) != SOFTSIM_OK) {
            fail_msg("%s", error.text);
        }
        assert_int_equal(s->load[0].node[0], 7);
        assert_true(ss_scene_renumber(s));
        const int32_t *file_node = s->mesh->file_node;
        assert_non_null(file_node);
        int moved = 0;
        for (int32_t i = 0; i < s->mesh->node_count; ++i) {
            const int32_t f = file_node[i];
            const bool is_held = f == 3 || f == 5 || f == 8;
            assert_int_equal(s->fixed[i], (is_held ? 7 : 0) | (f % 2 == 0 ? 2 : 0));
            assert_true(s->param[0].per_node[i] == 1.0 + 1e-3 * f);
            moved += f != i;
        }
        assert_true(moved > s->mesh->node_count / 2);
        for (int32_t e = 0; e < ss_mesh_element_count(s->mesh); ++e) {
            const double f = s->mesh->file_element[e];
            assert_true(fabs(s->param[1].per_element[e][0] - f / sqrt(f * f + 1.0)) < 1e-15);
            assert_null(s->param[2].per_node);
            assert_true(s->param[2].by_element[e] == 2.0 + 1e-3 * f);
        }
        const ss_mesh_group *group = &s->mesh->group[0];
        assert_int_equal(group->node_count, (s->mesh->node_count + 1) / 2);
        for (int32_t i = 0; i < group->node_count; ++i) {
            assert_int_equal(file_node[group->node[i]] % 2, 0);
            assert_true(i == 0 || group->node[i] > group->node[i - 1]);
        }
        static const int32_t loaded[3] = {7, 31, 100};
        for (int32_t i = 0; i < 3; ++i) {
            assert_int_equal(file_node[s->load[0].node[i]], loaded[i]);
        }
        for (int32_t i = 0; i < 6; ++i) {
            assert_int_equal(file_node[s->prescribed[0].node[i]], 20 + i);
            assert_true(s->prescribed[0].displacement[i][2] == 1e-5 * (20 + i));
        }
        ss_scene_destroy(&s);
    }
}

/* What is wrong with a file of elements, by line; a row that takes nodes alone says so. */
TEST(element_files_are_read_with_care)
{
    static const struct {
        const char *file, *key, *message;
    } rows[] = {
        {"element,value\n0,1\n", "stiff", "gives no value to"},
        {"element,value\n0,1\n0,2\n", "stiff", "bad.csv:3: error: element 0 is given twice"},
        {"element,value\n99999,1\n", "stiff", "bad.csv:2: error: there is no element 99999"},
        {"element,value\n0,11\n", "stiff", "bad.csv:2: error: the value"},
        {"element,value\n0\n", "stiff", "not two cells; each row is element,value"},
        {"tet,value\n", "stiff", "it must be node,value or element,value"},
        {"element,value\n0,1\n", "rho", "it must be node,value"},
    };
    ss_mesh *mesh = make_scattered(TRIANGLES);
    write_files("s.msh", mesh);
    ss_mesh_destroy(&mesh);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
        char text[160];
        ss_scene *s = NULL;
        FILE *file = open_file("bad.csv");
        fputs(rows[k].file, file);
        fclose(file);
        snprintf(text, sizeof text,
                 "softsim: 1\nobject: {mesh: s.msh, units: m}\n"
                 "model: {name: jelly, %s: {file: bad.csv}}\n",
                 rows[k].key);
        error = (softsim_error){0};
        assert_int_not_equal(ss_scene_load_text(in_folder("s.yaml"), text, strlen(text), NULL, 0,
                                                &jelly, 1, NULL, &s, &error),
                             SOFTSIM_OK);
        if (!strstr(error.text, rows[k].message)) {
            fail_msg("'%s' does not say '%s'", error.text, rows[k].message);
        }
    }
}

/* ---- the world ---- */

/* A scene whose every part is given by numbers, on `mesh`, whose node i is node order[i] of the
 * plain one. */
static void write_scene(const char *name, const ss_mesh *mesh, const int32_t *order)
{
    char text[64];
    snprintf(text, sizeof text, "%s.msh", name);
    write_files(text, mesh);
    int32_t number[400];
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        number[order[i]] = i;
    }
    snprintf(text, sizeof text, "%s.rho.csv", name);
    FILE *file = open_file(text);
    fprintf(file, "node,value\n");
    for (int32_t i = 0; i < mesh->node_count; ++i) {
        fprintf(file, "%d,%.17g\n", i, 0.05 + 1e-4 * order[i]);
    }
    fclose(file);
    snprintf(text, sizeof text, "%s.yaml", name);
    file = open_file(text);
    fprintf(file, "softsim: 1\nobject:\n  mesh: %s.msh\n  units: m\n  fixed: [{nodes: [", name);
    for (int32_t c = 0; c < 16; ++c) {
        fprintf(file, "%d, %d%s", number[c], number[320 + c], c < 15 ? ", " : "]}]\n");
    }
    fprintf(file,
            "model: {name: cnn-energy, modulus_n_per_m: 60, rho: {file: %s.rho.csv}, "
            "area_density_kg_m2: 10, damping_n_s_per_m3: 2000, rest_stiffness_n_per_m3: 5000}\n"
            "loads: [{nodes: [%d, %d, %d], force_n: [0, 0.01, -0.05]}]\n"
            "prescribed: [{nodes: [%d], displacement_m: [0, 0, 0.004]}]\n",
            name, number[100], number[101], number[117], number[200]);
    fclose(file);
}

static softsim_world *run(const char *name, int32_t ticks)
{
    softsim_config config = softsim_default_config();
    softsim_force force[SOFTSIM_MAX_PROBES];
    error = (softsim_error){0};
    softsim_world *world = softsim_create(in_folder(name), &config, &error);
    if (!world) {
        fail_msg("%s", error.text);
    }
    for (int32_t i = 0; i < ticks; ++i) {
        softsim_tick(world, NULL, NULL, 0, force);
    }
    return world;
}

TEST(a_shuffled_file_gives_the_same_body_in_its_own_numbers)
{
    enum { NODES = 21 * 16, TICKS = 200 };
    for (kind what = TRIANGLES; what <= QUADS; ++what) {
        ss_mesh *mesh = make(QUADS);
        if (what == TRIANGLES) {
            ss_mesh *cut = NULL;
            assert_int_equal(ss_mesh_create(mesh->node_count, (const double(*)[3])mesh->position,
                                            mesh->triangle_count,
                                            (const int32_t(*)[3])mesh->triangle, 0, NULL, &cut,
                                            &error),
                             SOFTSIM_OK);
            ss_mesh_destroy(&mesh);
            mesh = cut;
        }
        ss_mesh *shuffled = scatter(mesh, what);
        int32_t *place = shuffle(NODES, 5); /* as scatter() did */
        int32_t plain[NODES], order[NODES];
        for (int32_t i = 0; i < NODES; ++i) {
            plain[i] = i;
            order[place[i]] = i;
        }
        write_scene("plain", mesh, plain);
        write_scene("shuffled", shuffled, order);
        softsim_world *a = run("plain.yaml", TICKS);
        softsim_world *b = run("shuffled.yaml", TICKS);
        static double x[2][NODES][3];
        static double u[2][NODES][3];
        static double v[2][NODES][3];
        softsim_read_nodes(a, x[0], u[0], v[0]);
        softsim_read_nodes(b, x[1], u[1], v[1]);
        double largest = 0.0;
        const double eps = sizeof(ss_real) == 4 ? 1e-7 : 1e-13;
        for (int32_t i = 0; i < NODES; ++i) {
            const int32_t k = place[i];
            largest = fmax(largest, ss_norm3(u[0][i]));
            for (int axis = 0; axis < 3; ++axis) {
                assert_true(fabs(u[0][i][axis] - u[1][k][axis]) < 100.0 * eps * 0.004);
                assert_true(fabs(v[0][i][axis] - v[1][k][axis]) < 1e4 * eps * 0.004);
                assert_true(fabs(x[1][k][axis] - u[1][k][axis] - shuffled->position[k][axis]) <
                            1e-15);
            }
        }
        assert_true(fabs(u[1][place[200]][2] - 0.004) < 10.0 * eps);
        assert_true(largest > 1e-3);
        double reaction[2][3];
        softsim_read_reaction(a, 0, reaction[0]);
        softsim_read_reaction(b, 0, reaction[1]);
        assert_true(ss_norm3(reaction[0]) > 1e-3);
        assert_true(fabs(reaction[0][2] - reaction[1][2]) < 1e3 * eps * ss_norm3(reaction[0]));

        /* Triangles in the file's order and numbers. */
        assert_int_equal(softsim_triangle_count(b), shuffled->triangle_count);
        assert_memory_equal(softsim_triangles(b), shuffled->triangle,
                            (size_t)shuffled->triangle_count * sizeof *shuffled->triangle);
        /* The hash runs over nodes in file order: that of the nodes just read, to its end. */
        const ss_world *world = (const ss_world *)b;
        assert_non_null(world->scene->mesh->file_node);
        uint64_t hash = SS_HASH_START;
        for (int32_t i = 0; i < NODES; ++i) {
            hash = ss_hash_bytes(hash, x[1][i], sizeof x[1][i]);
            hash = ss_hash_bytes(hash, v[1][i], sizeof v[1][i]);
        }
        hash = world->model_class->hash(world->model, hash);
        assert_true(softsim_hash(b) == ss_hash_bytes(hash, &world->steps, sizeof world->steps));
        softsim_destroy(&a);
        softsim_destroy(&b);
        free(place);
        ss_mesh_destroy(&mesh);
        ss_mesh_destroy(&shuffled);
    }
}

/* ---- units ---- */

/* A 5 mm sphere presses, slides and leaves the plate of `file`, a mesh in `units`. */
static void press(const char *file, const char *units, softsim_force out[], int32_t ticks)
{
    FILE *scene = open_file("units.yaml");
    fprintf(scene,
            "softsim: 1\n"
            "object: {mesh: %s, units: %s, fixed: [{box_m: [[-1, -1, -1], [-0.06, 1, 1]]}]}\n"
            "model: {name: cnn-energy, modulus_j: 2, pretension_j: 0.5, area_density_kg_m2: 10, "
            "damping_n_s_per_m3: 2000, rest_stiffness_n_per_m3: 50000}\n"
            "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}]}\n",
            file, units);
    fclose(scene);
    softsim_world *world = run("units.yaml", 0);
    for (int32_t k = 0; k < ticks; ++k) {
        const double way = (double)k / ticks;
        softsim_pose pose = {.sender = 7, .seq = k + 1, .force_seq = -1};
        pose.position[0] = 0.004 * way;
        pose.position[2] = 0.006 - 0.005 * sin(3.0 * way);
        pose.orientation[0] = 1.0;
        for (int i = 0; i < 3; ++i) {
            pose.velocity[i] = pose.applied_force[i] = (double)NAN;
        }
        const int32_t channel = 0;
        softsim_force force[SOFTSIM_MAX_PROBES];
        softsim_tick(world, &pose, &channel, 1, force);
        out[k] = force[0];
    }
    softsim_destroy(&world);
}

TEST(newtons_know_neither_units_nor_numbers)
{
    enum { TICKS = 400 };
    static softsim_force in_metres[TICKS], in_millimetres[TICKS], shuffled[TICKS];
    ss_mesh *mesh = make(QUADS);
    write_files("metres.msh", mesh);
    ss_mesh *scattered = scatter(mesh, QUADS);
    write_files("shuffled.msh", scattered);
    ss_mesh_destroy(&scattered);
    for (int32_t i = 0; i < 3 * mesh->node_count; ++i) {
        mesh->position[i / 3][i % 3] *= 1000.0;
    }
    write_files("millimetres.msh", mesh);
    ss_mesh_destroy(&mesh);
    press("metres.msh", "m", in_metres, TICKS);
    press("millimetres.msh", "mm", in_millimetres, TICKS);
    press("shuffled.msh", "m", shuffled, TICKS);
    double largest = 0.0, apart[2] = {0.0};
    for (int32_t k = 0; k < TICKS; ++k) {
        double difference[3];
        largest = fmax(largest, ss_norm3(in_metres[k].force));
        ss_sub3(difference, in_metres[k].force, in_millimetres[k].force);
        apart[0] = fmax(apart[0], ss_norm3(difference));
        ss_sub3(difference, in_metres[k].force, shuffled[k].force);
        apart[1] = fmax(apart[1], ss_norm3(difference));
    }
    print_message("%.3f N at most; millimetres differ by %.1e N, shuffled numbers by %.1e N\n",
                  largest, apart[0], apart[1]);
    assert_true(largest > 0.1);
    const double rounding = (sizeof(ss_real) == 4 ? 1e-4 : 1e-10) * largest;
    assert_true(apart[0] < rounding && apart[1] < rounding);
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
