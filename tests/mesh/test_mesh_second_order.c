/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Tetrahedra of second order: each format's order of the nodes in the middle of sides, by the book;
 * what is wrong with them; writing, mending and renumbering. The independent check of an order:
 * each such node lies nearest the middle of its own side.
 */
#include "common/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/folder_fixture.h"
#include "common/mesh_fixture.h"
#include "mesh/mesh.h"
#include "rt/memory.h"
#include "rt/random.h"
#include "rt/vec.h"

/* ---- a bent block ---- */

/* A grid of points of half the cells' size: those of even places are corners, six tetrahedra to a
 * cube. All points are bent together, so that sides are curved; numbers are shuffled. */
enum { CELLS = 3, SIDE = 2 * CELLS + 1, POINTS = SIDE * SIDE * SIDE };
enum { TETS = 6 * CELLS * CELLS * CELLS };

static const int ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

static double position[POINTS][3]; /* by number */
static int32_t ten[TETS][10];      /* corners, then sides 01 02 03 12 13 23 */
static int32_t node_count;

/* The points of a grid that are corners or middles: all of them, for every diagonal is a side. */
static int make_block(void **state)
{
    static const int step[3] = {1, SIDE, SIDE * SIDE};
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
    static int32_t number[POINTS];
    uint64_t random = 17;
    for (int i = 0; i < POINTS; ++i) {
        number[i] = i;
    }
    for (int i = POINTS - 1; i > 0; --i) {
        const int k = (int)(ss_random_next(&random) % (uint64_t)(i + 1));
        const int32_t one = number[i];
        number[i] = number[k];
        number[k] = one;
    }
    node_count = POINTS;
    for (int i = 0; i < POINTS; ++i) {
        const double x = i % SIDE, y = i / SIDE % SIDE, z = i / (SIDE * SIDE);
        double *at = position[number[i]];
        at[0] = x / 3.0 + 0.05 * sin(1.3 * y);
        at[1] = y / 3.0 + 0.04 * sin(1.1 * z);
        at[2] = z / 3.0 + 0.05 * sin(1.2 * x);
    }
    int count = 0;
    for (int c = 0; c < CELLS * CELLS * CELLS; ++c) {
        const int a = 2 * (c % CELLS) + 2 * SIDE * (c / CELLS % CELLS) +
                      2 * SIDE * SIDE * (c / (CELLS * CELLS));
        for (int o = 0; o < 6; ++o, ++count) {
            const int b = a + 2 * step[order[o][0]];
            const int d = b + 2 * step[order[o][1]];
            const int e = d + 2 * step[order[o][2]];
            const int node[4] = {a, o < 3 ? b : d, o < 3 ? d : b, e};
            for (int k = 0; k < 4; ++k) {
                ten[count][k] = number[node[k]];
            }
            for (int s = 0; s < 6; ++s) {
                ten[count][4 + s] = number[(node[ends[s][0]] + node[ends[s][1]]) / 2];
            }
        }
    }
    return make_folder(state);
}

static ss_mesh *make_reference(void)
{
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_create_second_order(node_count, (const double(*)[3])position, TETS,
                                                 (const int32_t(*)[10])ten, &mesh, NULL),
                     SOFTSIM_OK);
    return mesh;
}

/* ---- by the book ---- */

/* Corners of the sides as each format lists them. Gmsh's manual, "Node ordering", Tetrahedron10;
 * VTK's vtkQuadraticTetra: (0,1) (1,2) (2,0) (0,3) (1,3) (2,3); tetgen -o2 as it writes. */
static const int gmsh[6][2] = {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {2, 3}, {1, 3}};
static const int vtk[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
static const int tetgen[6][2] = {{2, 3}, {0, 3}, {0, 1}, {1, 2}, {1, 3}, {0, 2}};

static int32_t middle_of(int e, const int side[2])
{
    for (int s = 0; s < 6; ++s) {
        if ((ends[s][0] == side[0] && ends[s][1] == side[1]) ||
            (ends[s][0] == side[1] && ends[s][1] == side[0])) {
            return ten[e][4 + s];
        }
    }
    abort();
}

static void put_nodes(FILE *file, int base)
{
    for (int i = 0; i < node_count; ++i) {
        if (base >= 0) {
            (void)fprintf(file, "%d ", base + i);
        }
        (void)fprintf(file, "%.17g %.17g %.17g\n", position[i][0], position[i][1], position[i][2]);
    }
}

static void put_ten(FILE *file, int e, int base, const int side[6][2])
{
    for (int k = 0; k < 10; ++k) {
        (void)fprintf(file, " %d", base + (k < 4 ? ten[e][k] : middle_of(e, side[k - 4])));
    }
    (void)fputc('\n', file);
}

/* Of element 0 a face, opposite corner 3, and a side, 01, name nodes. */
static void put_face(FILE *file)
{
    const int32_t *n = ten[0];
    (void)fprintf(file, "%d %d %d %d %d %d\n", n[0] + 1, n[1] + 1, n[2] + 1, n[4] + 1, n[7] + 1,
                  n[5] + 1);
}

static void write_msh2(FILE *file)
{
    (void)fprintf(file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", node_count);
    put_nodes(file, 1);
    (void)fprintf(file, "$EndNodes\n$Elements\n%d\n1 8 2 5 1 %d %d %d\n2 9 2 7 1 ", TETS + 2,
                  ten[0][0] + 1, ten[0][1] + 1, ten[0][4] + 1);
    put_face(file);
    for (int e = 0; e < TETS; ++e) {
        (void)fprintf(file, "%d 11 2 3 1", e + 3);
        put_ten(file, e, 1, gmsh);
    }
    (void)fprintf(file, "$EndElements\n");
}

static void write_msh4(FILE *file)
{
    (void)fprintf(file,
                  "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 1 1 1\n"
                  "1 0 0 0 1 1 1 1 5 0\n1 0 0 0 1 1 1 1 7 0\n1 0 0 0 1 1 1 1 3 0\n$EndEntities\n"
                  "$Nodes\n1 %d 1 %d\n3 1 0 %d\n",
                  node_count, node_count, node_count);
    for (int i = 0; i < node_count; ++i) {
        (void)fprintf(file, "%d\n", i + 1);
    }
    put_nodes(file, -1);
    (void)fprintf(file, "$EndNodes\n$Elements\n3 %d 1 %d\n1 1 8 1\n1 %d %d %d\n2 1 9 1\n2 ",
                  TETS + 2, TETS + 2, ten[0][0] + 1, ten[0][1] + 1, ten[0][4] + 1);
    put_face(file);
    (void)fprintf(file, "3 1 11 %d\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fprintf(file, "%d", e + 3);
        put_ten(file, e, 1, gmsh);
    }
    (void)fprintf(file, "$EndElements\n");
}

static void write_vtk(FILE *file)
{
    (void)fprintf(file,
                  "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                  "POINTS %d double\n",
                  node_count);
    put_nodes(file, -1);
    (void)fprintf(file, "CELLS %d %d\n", TETS, 11 * TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fputs("10", file);
        put_ten(file, e, 0, vtk);
    }
    (void)fprintf(file, "CELL_TYPES %d\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fputs("24\n", file);
    }
    (void)fprintf(file, "CELL_DATA %d\nSCALARS region int\nLOOKUP_TABLE default\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fputs(e == 0 ? "3 " : "4 ", file);
    }
    (void)fputc('\n', file);
}

static void write_vtu(FILE *file)
{
    (void)fprintf(file,
                  "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>"
                  "<Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n<Points><DataArray "
                  "type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n",
                  node_count, TETS);
    put_nodes(file, -1);
    (void)fputs("</DataArray></Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\">",
                file);
    for (int e = 0; e < TETS; ++e) {
        put_ten(file, e, 0, vtk);
    }
    (void)fputs("</DataArray><DataArray type=\"Int64\" Name=\"offsets\">", file);
    for (int e = 0; e < TETS; ++e) {
        (void)fprintf(file, "%d ", 10 * e + 10);
    }
    (void)fputs("</DataArray><DataArray type=\"UInt8\" Name=\"types\">", file);
    for (int e = 0; e < TETS; ++e) {
        (void)fputs("24 ", file);
    }
    (void)fputs("</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>\n", file);
}

static void write_tetgen(void)
{
    FILE *file = open_file("o2.node");
    (void)fprintf(file, "%d 3 0 0\n", node_count);
    put_nodes(file, 1);
    assert_int_equal(fclose(file), 0);
    file = open_file("o2.ele");
    (void)fprintf(file, "%d 10 1\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        char line[256];
        FILE *text = fmemopen(line, sizeof line, "w");
        assert_non_null(text);
        put_ten(text, e, 1, tetgen);
        assert_int_equal(fclose(text), 0);
        line[strcspn(line, "\n")] = '\0';
        (void)fprintf(file, "%d%s %d\n", e + 1, line, e == 0 ? 3 : 4);
    }
    assert_int_equal(fclose(file), 0);
}

/* ---- invariants ---- */

static double distance_to_middle(const ss_mesh *m, int32_t e, int s, int32_t node)
{
    double d[3];
    const double *a = m->position[m->tetrahedron[e][ends[s][0]]];
    const double *b = m->position[m->tetrahedron[e][ends[s][1]]];
    for (int i = 0; i < 3; ++i) {
        d[i] = m->position[node][i] - 0.5 * (a[i] + b[i]);
    }
    return ss_norm3(d);
}

static void expect_own_middles(const ss_mesh *m)
{
    assert_non_null(m->middle);
    for (int32_t e = 0; e < m->tetrahedron_count; ++e) {
        for (int s = 0; s < 6; ++s) {
            const double own = distance_to_middle(m, e, s, m->middle[e][s]);
            for (int other = 0; other < 6; ++other) {
                assert_true(other == s || own < distance_to_middle(m, e, other, m->middle[e][s]));
            }
        }
    }
}

/* Each quarter has a corner of its face and the middles of the sides beside it. */
static void expect_quarters(const ss_mesh *m)
{
    assert_int_equal(m->triangle_count % 4, 0);
    for (int32_t f = 0; f < m->triangle_count; f += 4) {
        const int32_t(*four)[3] = (const int32_t(*)[3])m->triangle + f;
        for (int k = 0; k < 3; ++k) {
            assert_int_equal(four[k][1], four[3][k]);
            assert_int_equal(four[k][2], four[3][(k + 2) % 3]);
            double d[3];
            for (int i = 0; i < 3; ++i) {
                d[i] = m->position[four[3][k]][i] -
                       0.5 * (m->position[four[k][0]][i] + m->position[four[(k + 1) % 3][0]][i]);
            }
            assert_true(ss_norm3(d) < 0.1);
        }
    }
}

static void expect_same(const ss_mesh *a, const ss_mesh *b)
{
    assert_int_equal(a->node_count, b->node_count);
    assert_int_equal(a->tetrahedron_count, b->tetrahedron_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_memory_equal(a->position, b->position, (size_t)a->node_count * sizeof *a->position);
    assert_memory_equal(a->tetrahedron, b->tetrahedron,
                        (size_t)a->tetrahedron_count * sizeof *a->tetrahedron);
    assert_memory_equal(a->middle, b->middle, (size_t)a->tetrahedron_count * sizeof *a->middle);
    assert_memory_equal(a->triangle, b->triangle, (size_t)a->triangle_count * sizeof *a->triangle);
}

static void expect_accepted(const ss_mesh *m)
{
    softsim_error error = {0};
    if (ss_mesh_accept(m, "it", &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
}

static ss_mesh *load(const char *path)
{
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    if (ss_mesh_load(path, 1.0, NULL, &mesh, &error) != SOFTSIM_OK) {
        fail_msg("%s", error.text);
    }
    return mesh;
}

static int32_t group_size(const ss_mesh *m, const char *name)
{
    for (int32_t g = 0; g < m->group_count; ++g) {
        if (strcmp(m->group[g].name, name) == 0) {
            return m->group[g].node_count;
        }
    }
    return 0;
}

TEST(every_format_gives_each_side_its_own_middle)
{
    static const struct {
        const char *name;
        void (*write)(FILE *file);
        const char *volume, *face, *line; /* groups */
    } formats[] = {{"two.msh", write_msh2, NULL, "surface-7", "line-5"},
                   {"four.msh", write_msh4, NULL, "surface-7", "line-5"},
                   {"grid.vtk", write_vtk, "region=3", NULL, NULL},
                   {"grid.vtu", write_vtu, NULL, NULL, NULL},
                   {"o2.ele", NULL, "region=3", NULL, NULL}};
    ss_mesh *reference = make_reference();
    expect_accepted(reference);
    for (int f = 0; f < COUNT(formats); ++f) {
        if (formats[f].write != NULL) {
            FILE *file = open_file(formats[f].name);
            formats[f].write(file);
            assert_int_equal(fclose(file), 0);
        } else {
            write_tetgen();
        }
        ss_mesh *m = load(in_folder(formats[f].name));
        expect_same(reference, m);
        expect_own_middles(m);
        expect_quarters(m);
        expect_accepted(m);
        assert_true(m->is_closed);
        /* Groups have the nodes in the middle too. */
        assert_true(formats[f].volume == NULL || group_size(m, formats[f].volume) == 10);
        assert_true(formats[f].face == NULL || group_size(m, formats[f].face) == 6);
        assert_true(formats[f].line == NULL || group_size(m, formats[f].line) == 3);
        for (int kind = SS_MESH_HIGHER_ORDER; kind < SS_MESH_KIND_COUNT; ++kind) {
            assert_int_equal(m->skipped[kind], 0);
        }
        ss_mesh_destroy(&m);
    }
    ss_mesh_destroy(&reference);
}

/* Of four points, by tetgen -zo2, version 1.5.0. */
TEST(a_file_that_tetgen_wrote_gives_each_side_its_own_middle)
{
    write_text("one.1.node",
               "10  3  0  0\n   0    0  0  0\n   1    2  0  0\n   2    0  3  0\n"
               "   3    0  0  4\n   4    1  0  2\n   5    1  0  0\n   6    0  1.5  0\n"
               "   7    0  1.5  2\n   8    1  1.5  0\n   9    0  0  2\n"
               "# Generated by tetgen -zo2 one.node \n");
    ss_mesh *m = load(write_text(
        "one.1.ele", "1  10  0\n    0       0     2     3     1      4     5     6     7     8     "
                     "9\n# Generated by tetgen -zo2 one.node \n"));
    expect_own_middles(m);
    expect_accepted(m);
    for (int s = 0; s < 6; ++s) {
        assert_near(distance_to_middle(m, 0, s, m->middle[0][s]), 0.0, 0.0);
    }
    ss_mesh_destroy(&m);
}

TEST(what_is_written_is_read_back_the_same)
{
    ss_mesh *m = make_reference();
    m->group = ss_memory_get(1, sizeof *m->group);
    assert_non_null(m->group);
    m->group_count = 1;
    (void)snprintf(m->group[0].name, sizeof m->group[0].name, "some");
    m->group[0].node = ss_memory_get(3, sizeof *m->group[0].node);
    assert_non_null(m->group[0].node);
    m->group[0].node_count = 3;
    for (int i = 0; i < 3; ++i) {
        m->group[0].node[i] = 7 + 11 * i;
    }
    assert_int_equal(ss_mesh_write_msh(m, in_folder("out.msh"), NULL), SOFTSIM_OK);
    assert_int_equal(ss_mesh_write_vtk(m, in_folder("out.vtk"), NULL), SOFTSIM_OK);
    assert_int_equal(ss_mesh_write_obj(m, in_folder("out.obj"), NULL), SOFTSIM_OK);
    static const char *const names[] = {"out.msh", "out.vtk"};
    for (int f = 0; f < 2; ++f) {
        ss_mesh *back = load(in_folder(names[f]));
        expect_same(m, back);
        assert_int_equal(back->group_count, 1);
        assert_int_equal(back->group[0].node_count, 3);
        assert_memory_equal(back->group[0].node, m->group[0].node, 3 * sizeof(int32_t));
        ss_mesh_destroy(&back);
    }
    ss_mesh_destroy(&m);
}

/* ---- faults ---- */

/* Two tetrahedra about x y z on a common face, straight. */
static const int32_t pair[2][10] = {{0, 1, 2, 3, 5, 6, 7, 8, 9, 10},
                                    {0, 2, 1, 4, 6, 5, 11, 8, 12, 13}};

static void make_pair(double x[16][3], int32_t out[3][10])
{
    static const double corner[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}};
    memcpy(x, corner, sizeof corner);
    memcpy(out, pair, sizeof pair);
    for (int s = 0; s < 12; ++s) {
        const double *a = corner[pair[s / 6][ends[s % 6][0]]];
        const double *b = corner[pair[s / 6][ends[s % 6][1]]];
        for (int i = 0; i < 3; ++i) {
            x[pair[s / 6][4 + s % 6]][i] = 0.5 * (a[i] + b[i]);
        }
    }
}

/* One fault and no other, with these words; NULL: none. */
static void expect_fault(int32_t nodes, double x[16][3], int32_t tet[3][10], const char *words)
{
    ss_mesh *m = NULL;
    softsim_error error = {0};
    assert_int_equal(ss_mesh_create_second_order(nodes, (const double(*)[3])x, 2,
                                                 (const int32_t(*)[10])tet, &m, &error),
                     SOFTSIM_OK);
    (void)ss_mesh_accept(m, "it", &error);
    print_message("%s\n", error.text);
    assert_int_equal(error.fault_count, words != NULL);
    assert_true(words == NULL || strstr(error.text, words) != NULL);
    ss_mesh_destroy(&m);
}

TEST(each_fault_of_second_order_is_named)
{
    static const char *const shared =
        "it: mid-edge nodes of more than one edge, or at a corner too: 1 (node ";
    char words[128];
    double x[16][3];
    int32_t tet[3][10];
    make_pair(x, tet);
    expect_fault(14, x, tet, NULL);
    tet[1][7] = 14; /* of edge 12 */
    ss_set3(x[14], 0.5, 0.51, 0.0);
    expect_fault(15, x, tet,
                 "it: edges that two tetrahedra give different mid-edge nodes: 1 (at node 1)");
    static const struct {
        int side;
        int32_t node;
    } wrong[] = {{2, 5}, {5, 3}, {5, 4}}; /* another edge's, its end, a corner of the other */
    for (int k = 0; k < COUNT(wrong); ++k) {
        make_pair(x, tet);
        tet[0][4 + wrong[k].side] = wrong[k].node;
        (void)snprintf(words, sizeof words, "%s%d)", shared, wrong[k].node);
        expect_fault(14, x, tet, words);
    }
    make_pair(x, tet);
    ss_set3(x[10], 0.0, -0.6, -0.6); /* of 23, beyond the opposite edge */
    expect_fault(14, x, tet,
                 "it: tetrahedra that their mid-edge nodes turn inside out: 1 (tetrahedron 0)");
    make_pair(x, tet);
    for (int e = 0; e < 2; ++e) { /* in another format's order */
        const int32_t last = tet[e][8];
        tet[e][8] = tet[e][9];
        tet[e][9] = last;
    }
    expect_fault(14, x, tet, "2 (tetrahedron 0, 1): write the nodes in the format's own order");
}

/* No reader lets them through, but who makes a mesh of arrays may. */
TEST(nodes_that_do_not_exist_are_not_followed)
{
    static const int32_t bad[] = {14, -1, INT32_MAX, INT32_MIN};
    for (int k = 0; k < COUNT(bad); ++k) {
        double x[16][3];
        int32_t tet[3][10];
        ss_mesh *m = NULL;
        softsim_error error = {0};
        make_pair(x, tet);
        tet[1][9] = bad[k];
        assert_int_equal(ss_mesh_create_second_order(14, (const double(*)[3])x, 2,
                                                     (const int32_t(*)[10])tet, &m, &error),
                         SOFTSIM_OK);
        assert_int_equal(ss_mesh_accept(m, "it", &error), SOFTSIM_ERROR_MESH);
        assert_non_null(strstr(error.text, "it: elements of nodes that do not exist: "));
        ss_mesh_destroy(&m);
    }
}

TEST(one_file_is_of_one_order)
{
    ss_mesh *m = NULL;
    softsim_error error = {0};
    static const char text[] =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
        "5 0 0 -1\n$EndNodes\n$Elements\n2\n1 4 0 1 2 3 4\n2 11 0 1 2 3 4 1 2 3 4 1 2\n"
        "$EndElements\n";
    assert_int_equal(ss_mesh_read_msh(text, sizeof text - 1, "t.msh", 1.0, &m, &error),
                     SOFTSIM_ERROR_FORMAT);
    assert_int_equal(error.fault_count, 1);
    assert_non_null(strstr(error.text, "1 cells of first order beside 1 tetrahedra of 10 nodes"));
}

/* ---- changes ---- */

TEST(mending_keeps_middles_with_their_sides)
{
    /* The second is inside out, the third there twice; node 14 is loose, 15 lies on 13. */
    double x[16][3];
    int32_t tet[3][10];
    make_pair(x, tet);
    ss_set3(x[14], 5.0, 5.0, 5.0);
    ss_copy3(x[15], x[13]);
    const int32_t turned[10] = {0, 1, 2, 4, 5, 6, 11, 8, 15, 12};
    memcpy(tet[1], turned, sizeof turned);
    memcpy(tet[2], tet[0], sizeof tet[0]);
    ss_mesh *given = NULL, *mended = NULL;
    ss_mesh_repairs done;
    assert_int_equal(ss_mesh_create_second_order(16, (const double(*)[3])x, 3,
                                                 (const int32_t(*)[10])tet, &given, NULL),
                     SOFTSIM_OK);
    assert_int_equal(ss_mesh_repair(given, &mended, &done, NULL), SOFTSIM_OK);
    assert_int_equal(done.turned_tetrahedron.count, 1);
    assert_int_equal(done.twin_element.count, 1);
    assert_int_equal(done.loose_node.count, 1);
    assert_int_equal(done.welded_node.count, 1);
    assert_int_equal(mended->node_count, 14);
    expect_own_middles(mended);
    expect_quarters(mended);
    expect_accepted(mended);
    ss_mesh_destroy(&given);
    ss_mesh_destroy(&mended);
}

/* Up, and down again the same; new nodes in the groups that have the whole of their side's place.
 */
TEST(the_order_can_be_changed_and_changed_back)
{
    ss_mesh *given = make_reference(), *first = NULL, *second = NULL, *again = NULL;
    assert_int_equal(ss_mesh_lower(given, &first, NULL), SOFTSIM_OK);
    assert_null(first->middle);
    assert_int_equal(first->node_count, (CELLS + 1) * (CELLS + 1) * (CELLS + 1));
    assert_int_equal(first->triangle_count, 4 * CELLS * CELLS * 3);
    first->group = ss_memory_get(2, sizeof *first->group);
    assert_non_null(first->group);
    first->group_count = 2;
    for (int g = 0; g < 2; ++g) { /* a tetrahedron, a face of the surface */
        const int32_t *node = g == 0 ? first->tetrahedron[5] : first->triangle[3];
        ss_mesh_group *group = &first->group[g];
        group->node_count = 4 - g;
        group->node = ss_memory_get(4, sizeof *group->node);
        assert_non_null(group->node);
        memcpy(group->node, node, (size_t)group->node_count * sizeof *node);
        (void)snprintf(group->name, sizeof group->name, "%d", g);
    }
    assert_int_equal(ss_mesh_raise(first, &second, NULL), SOFTSIM_OK);
    expect_accepted(second);
    expect_quarters(second);
    for (int32_t e = 0; e < second->tetrahedron_count; ++e) {
        for (int s = 0; s < 6; ++s) {
            assert_near(distance_to_middle(second, e, s, second->middle[e][s]), 0.0, 1e-15);
        }
    }
    assert_int_equal(second->node_count, given->node_count);
    assert_int_equal(second->group[0].node_count, 10);
    assert_int_equal(second->group[1].node_count, 6);
    assert_int_equal(ss_mesh_lower(second, &again, NULL), SOFTSIM_OK);
    assert_int_equal(again->node_count, first->node_count);
    assert_memory_equal(again->position, first->position,
                        (size_t)first->node_count * sizeof *first->position);
    assert_memory_equal(again->tetrahedron, first->tetrahedron, sizeof(int32_t[TETS][4]));
    assert_int_equal(again->group[0].node_count, 4);
    assert_int_equal(again->group[1].node_count, 3);
    ss_mesh_destroy(&again);
    softsim_error error = {0};
    assert_int_equal(ss_mesh_raise(second, &again, &error), SOFTSIM_ERROR_MESH);
    assert_non_null(strstr(error.text, "of second order already"));
    ss_mesh_destroy(&given);
    ss_mesh_destroy(&first);
    ss_mesh_destroy(&second);
}

TEST(renumbered_nodes_lead_back_to_the_file)
{
    ss_mesh *file = make_reference(), *m = make_reference();
    assert_true(ss_mesh_renumber(m));
    assert_non_null(m->file_node);
    assert_non_null(m->file_element);
    expect_own_middles(m);
    expect_quarters(m);
    expect_accepted(m);
    for (int32_t i = 0; i < m->node_count; ++i) {
        assert_memory_equal(m->position[i], file->position[m->file_node[i]], sizeof *m->position);
    }
    for (int32_t e = 0; e < m->tetrahedron_count; ++e) {
        for (int s = 0; s < 6; ++s) {
            assert_int_equal(m->file_node[m->middle[e][s]], file->middle[m->file_element[e]][s]);
        }
    }
    ss_mesh_destroy(&file);
    ss_mesh_destroy(&m);
}

int main(void)
{
    return run_all_tests(make_block, remove_folder);
}
