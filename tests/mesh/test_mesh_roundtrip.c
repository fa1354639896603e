/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * One mesh in every format is one mesh: a block of thousands of tetrahedra with positions of all 53
 * bits, larger than the window over a file, written here by the book of each format, and by our
 * writers; read back, it must be the same to the last bit.
 */
#include "common/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/tool_fixture.h"
#include "mesh/mesh.h"
#include "mesh/text.h"
#include "rt/memory.h"
#include "rt/random.h"

enum { CELLS = 11, SIDE = CELLS + 1, NODES = SIDE * SIDE * SIDE, TETS = 6 * CELLS * CELLS * CELLS };

static double position[NODES][3];
static int32_t tetrahedron[TETS][4];
static int32_t region[TETS]; /* 3 or 12 */

/* A block of cubes in six tetrahedra each, its nodes shaken. */
static int make_block(void **state)
{
    static const int step[3] = {1, SIDE, SIDE * SIDE};
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
    uint64_t random = 99;
    for (int i = 0; i < NODES; ++i) {
        const int at[3] = {i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)};
        for (int k = 0; k < 3; ++k) {
            position[i][k] = (at[k] + 0.1 * ss_random_unit(&random)) / CELLS;
        }
    }
    int count = 0;
    for (int c = 0; c < CELLS * CELLS * CELLS; ++c) {
        const int a = c % CELLS + SIDE * (c / CELLS % CELLS) + SIDE * SIDE * (c / (CELLS * CELLS));
        for (int o = 0; o < 6; ++o, ++count) {
            const int b = a + step[order[o][0]];
            const int d = b + step[order[o][1]];
            const int e = d + step[order[o][2]];
            const int node[4] = {a, o < 3 ? b : d, o < 3 ? d : b, e};
            for (int k = 0; k < 4; ++k) {
                tetrahedron[count][k] = node[k];
            }
            region[count] = c < CELLS * CELLS ? 12 : 3;
        }
    }
    return make_folder(state);
}

/* ---- by the book ---- */

/* `base`: the first node's number; `gap`: added to the second half's. */
static int tag_of(int node, int base, int gap)
{
    return base + node + (node >= NODES / 2 ? gap : 0);
}

static void put_nodes(FILE *file, int base, int gap, const char *end)
{
    for (int i = 0; i < NODES; ++i) {
        if (base >= 0) {
            (void)fprintf(file, "%d ", tag_of(i, base, gap));
        }
        (void)fprintf(file, "%.17g %.17g %.17g%s", position[i][0], position[i][1], position[i][2],
                      end);
    }
}

static void put_element_nodes(FILE *file, int e, int base, int gap, const char *end)
{
    for (int k = 0; k < 4; ++k) {
        (void)fprintf(file, " %d", tag_of(tetrahedron[e][k], base, gap));
    }
    (void)fputs(end, file);
}

static void write_msh1(FILE *file)
{
    (void)fprintf(file, "$NOD\n%d\n", NODES);
    put_nodes(file, 1, 1000, "\n");
    (void)fprintf(file, "$ENDNOD\n$ELM\n%d\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fprintf(file, "%d 4 %d 1 4", e + 1, region[e]);
        put_element_nodes(file, e, 1, 1000, "\n");
    }
    (void)fprintf(file, "$ENDELM\n");
}

static void write_msh2(FILE *file)
{
    (void)fprintf(file, "$MeshFormat\r\n2.2 0 8\r\n$EndMeshFormat\r\n$Nodes\r\n%d\r\n", NODES);
    put_nodes(file, 1, 0, "\r\n");
    (void)fprintf(file, "$EndNodes\r\n$Elements\r\n%d\r\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fprintf(file, "%d 4 2 %d 1", e + 1, region[e]);
        put_element_nodes(file, e, 1, 0, "\r\n");
    }
    (void)fprintf(file, "$EndElements");
}

/* Two volumes, the lower layer of which comes first in the file. */
static void write_msh4(FILE *file)
{
    const int lower = 6 * CELLS * CELLS;
    (void)fprintf(file,
                  "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 2\n8 0 0 0 1 1 1 1 12 0\n"
                  "2 0 0 0 1 1 1 1 3 0\n$EndEntities\n$Nodes\n2 %d 7 99999\n3 2 0 1\n%d\n"
                  "%.17g %.17g %.17g\n3 8 0 %d\n",
                  NODES, tag_of(0, 7, 50000), position[0][0], position[0][1], position[0][2],
                  NODES - 1);
    for (int i = 1; i < NODES; ++i) {
        (void)fprintf(file, "%d\n", tag_of(i, 7, 50000));
    }
    for (int i = 1; i < NODES; ++i) {
        (void)fprintf(file, "%.17g %.17g %.17g\n", position[i][0], position[i][1], position[i][2]);
    }
    (void)fprintf(file, "$EndNodes\n$Elements\n2 %d 1 %d\n", TETS, TETS);
    for (int e = 0; e < TETS; ++e) {
        if (e == 0 || e == lower) {
            (void)fprintf(file, "3 %d 4 %d\n", e == 0 ? 8 : 2, e == 0 ? lower : TETS - lower);
        }
        (void)fprintf(file, "%d", e + 1);
        put_element_nodes(file, e, 7, 50000, "\n");
    }
    (void)fprintf(file, "$EndElements\n");
}

static void write_node(FILE *file, int base)
{
    (void)fprintf(file, "%d 3 0 0\n", NODES);
    put_nodes(file, base, 0, "\n");
}

static void write_ele(FILE *file, int base)
{
    (void)fprintf(file, "%d 4 1\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fprintf(file, "%d", e + base);
        put_element_nodes(file, e, base, 0, "");
        (void)fprintf(file, " %d\n", region[e]);
    }
}

/* All numbers of an array on one line: lines longer than any window. */
static void write_vtk(FILE *file)
{
    (void)fprintf(file,
                  "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS %d "
                  "double\n",
                  NODES);
    put_nodes(file, -1, 0, " ");
    (void)fprintf(file, "\nCELLS %d %d\n", TETS, 5 * TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fputs(" 4", file);
        put_element_nodes(file, e, 0, 0, "");
    }
    (void)fprintf(file, "\nCELL_TYPES %d\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fputs("10 ", file);
    }
    (void)fprintf(file, "\nCELL_DATA %d\nSCALARS region int\nLOOKUP_TABLE default\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        (void)fprintf(file, "%d ", region[e]);
    }
}

static void put_big_endian(FILE *file, uint64_t value, int bytes)
{
    for (int k = bytes - 1; k >= 0; --k) {
        (void)fputc((int)(value >> (8 * k) & 0xff), file);
    }
}

static void write_binary(FILE *file, bool is_new)
{
    (void)fprintf(file,
                  "# vtk DataFile Version %s\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS %d "
                  "double\n",
                  is_new ? "5.1" : "4.2", NODES);
    for (int i = 0; i < 3 * NODES; ++i) {
        uint64_t bits;
        memcpy(&bits, &position[i / 3][i % 3], sizeof bits);
        put_big_endian(file, bits, 8);
    }
    (void)fprintf(file, is_new ? "\nCELLS %d %d\nOFFSETS vtktypeint64\n" : "\nCELLS %d %d\n",
                  is_new ? TETS + 1 : TETS, is_new ? 4 * TETS : 5 * TETS);
    for (int e = 0; e <= TETS && is_new; ++e) {
        put_big_endian(file, (uint64_t)(4 * e), 8);
    }
    (void)fputs(is_new ? "\nCONNECTIVITY vtktypeint64\n" : "", file);
    for (int e = 0; e < TETS; ++e) {
        if (!is_new) {
            put_big_endian(file, 4, 4);
        }
        for (int k = 0; k < 4; ++k) {
            put_big_endian(file, (uint64_t)tetrahedron[e][k], is_new ? 8 : 4);
        }
    }
    (void)fprintf(file, "\nCELL_TYPES %d\n", TETS);
    for (int e = 0; e < TETS; ++e) {
        put_big_endian(file, 10, 4);
    }
    (void)fprintf(file, "\nCELL_DATA %d\nFIELD FieldData 1\nregion 1 %d unsigned_char\n", TETS,
                  TETS);
    for (int e = 0; e < TETS; ++e) {
        put_big_endian(file, (uint64_t)region[e], 1);
    }
}

static void write_vtu(FILE *file)
{
    (void)fprintf(file,
                  "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>"
                  "<Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">\n<Points><DataArray "
                  "type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n",
                  NODES, TETS);
    put_nodes(file, -1, 0, " ");
    (void)fprintf(file, "</DataArray></Points><Cells>\n<DataArray type=\"Int64\" "
                        "Name=\"connectivity\" format=\"ascii\">");
    for (int e = 0; e < TETS; ++e) {
        put_element_nodes(file, e, 0, 0, "");
    }
    (void)fprintf(file, "</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\">");
    for (int e = 0; e < TETS; ++e) {
        (void)fprintf(file, "%d ", 4 * e + 4);
    }
    (void)fprintf(file, "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\">");
    for (int e = 0; e < TETS; ++e) {
        (void)fputs("10\n", file);
    }
    (void)fprintf(file, "</DataArray></Cells><CellData><DataArray type=\"Int32\" Name=\"region\">");
    for (int e = 0; e < TETS; ++e) {
        (void)fprintf(file, "%d ", region[e]);
    }
    (void)fprintf(file, "</DataArray></CellData></Piece></UnstructuredGrid></VTKFile>\n");
}

/* ---- the same mesh ---- */

static void expect_same_groups(const ss_mesh *a, const ss_mesh *b)
{
    assert_int_equal(a->group_count, b->group_count);
    for (int32_t g = 0; g < a->group_count; ++g) {
        assert_int_equal(a->group[g].node_count, b->group[g].node_count);
        assert_memory_equal(a->group[g].node, b->group[g].node,
                            (size_t)a->group[g].node_count * sizeof(int32_t));
    }
}

static void expect_same(const ss_mesh *a, const ss_mesh *b)
{
    assert_int_equal(a->node_count, b->node_count);
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_int_equal(a->quad_count, b->quad_count);
    assert_int_equal(a->tetrahedron_count, b->tetrahedron_count);
    assert_int_equal(a->is_closed, b->is_closed);
    assert_memory_equal(a->position, b->position, (size_t)a->node_count * sizeof *a->position);
    assert_memory_equal(a->triangle, b->triangle, (size_t)a->triangle_count * sizeof *a->triangle);
    if (a->quad_count > 0) {
        assert_memory_equal(a->quad, b->quad, (size_t)a->quad_count * sizeof *a->quad);
    }
    if (a->tetrahedron_count > 0) {
        assert_memory_equal(a->tetrahedron, b->tetrahedron,
                            (size_t)a->tetrahedron_count * sizeof *a->tetrahedron);
    }
}

/* What the arrays of this file say, with the two regions as groups. */
static ss_mesh *make_reference(void)
{
    ss_mesh *mesh = NULL;
    assert_int_equal(ss_mesh_create(NODES, (const double(*)[3])position, 0, NULL, TETS,
                                    (const int32_t(*)[4])tetrahedron, &mesh, NULL),
                     SOFTSIM_OK);
    mesh->group = ss_memory_get(2, sizeof *mesh->group);
    assert_non_null(mesh->group);
    mesh->group_count = 2;
    for (int g = 0; g < 2; ++g) {
        bool is_in[NODES] = {false};
        ss_mesh_group *group = &mesh->group[g];
        (void)snprintf(group->name, sizeof group->name, "part %d: 100%%, \"%s\"", g, "a=b");
        group->node = ss_memory_get(NODES, sizeof *group->node);
        assert_non_null(group->node);
        for (int e = 0; e < TETS; ++e) {
            for (int k = 0; k < 4; ++k) {
                is_in[tetrahedron[e][k]] |= region[e] == (g == 0 ? 3 : 12);
            }
        }
        for (int i = 0; i < NODES; ++i) {
            if (is_in[i]) {
                group->node[group->node_count++] = i;
            }
        }
    }
    return mesh;
}

TEST(one_mesh_in_every_format_is_one_mesh)
{
    static const char *const names[] = {"1.msh",    "2.msh",   "4.msh",   "0.node", "1.node",
                                        "text.vtk", "old.vtk", "new.vtk", "x.vtu"};
    static const char *const groups[] = {"volume-3", "volume-3", "volume-3", "region=3", "region=3",
                                         "region=3", "region=3", "region=3", "region=3"};
    ss_mesh *reference = make_reference();
    for (int f = 0; f < (int)(sizeof names / sizeof names[0]); ++f) {
        FILE *file = open_file(names[f]);
        switch (f) {
        case 0:
            write_msh1(file);
            break;
        case 1:
            write_msh2(file);
            break;
        case 2:
            write_msh4(file);
            break;
        case 5:
            write_vtk(file);
            break;
        case 6:
        case 7:
            write_binary(file, f == 7);
            break;
        case 8:
            write_vtu(file);
            break;
        default: {
            write_node(file, f - 3);
            FILE *other = open_file(f == 3 ? "0.ele" : "1.ele");
            write_ele(other, f - 3);
            assert_int_equal(fclose(other), 0);
        }
        }
        assert_int_equal(fclose(file), 0);
        ss_mesh *mesh = load(in_folder(names[f]), 1.0);
        print_message("%-8s %d nodes, %d tetrahedra, group %s of %d\n", names[f], mesh->node_count,
                      mesh->tetrahedron_count, mesh->group[0].name, mesh->group[0].node_count);
        expect_same(mesh, reference);
        expect_same_groups(mesh, reference);
        assert_string_equal(mesh->group[0].name, groups[f]);
        ss_mesh_destroy(&mesh);
    }
    ss_mesh_destroy(&reference);
}

TEST(what_we_write_comes_back_to_the_last_bit)
{
    ss_mesh *mesh = make_reference();
    assert_int_equal(ss_mesh_write_msh(mesh, in_folder("our.msh"), NULL), SOFTSIM_OK);
    assert_int_equal(ss_mesh_write_vtk(mesh, in_folder("our.vtk"), NULL), SOFTSIM_OK);
    for (int i = 0; i < 2; ++i) {
        ss_mesh *back = load(in_folder(i == 0 ? "our.msh" : "our.vtk"), 1.0);
        expect_same(back, mesh);
        expect_same_groups(back, mesh);
        for (int g = 0; g < 2; ++g) {
            assert_string_equal(back->group[g].name, mesh->group[g].name);
        }
        ss_mesh_destroy(&back);
    }
    ss_mesh_destroy(&mesh);
}

TEST(surfaces_come_back_to_the_last_bit)
{
    static const double turn[3] = {10, 20, 30};
    static const double away[3] = {0.1, 0.2, 0.3};
    static const char *const names[] = {"face.obj", "face.msh", "face.vtk"};
    for (int is_quad = 0; is_quad < 2; ++is_quad) {
        ss_mesh *mesh = NULL;
        assert_int_equal(ss_mesh_create_cylinder(7, 9, 1.0, 3.0, &mesh, NULL), SOFTSIM_OK);
        ss_mesh_transform(mesh, 1.0 / 3.0, turn, away);
        if (is_quad == 0) {
            ss_mesh *cut = NULL;
            assert_int_equal(ss_mesh_create(mesh->node_count, (const double(*)[3])mesh->position,
                                            mesh->triangle_count,
                                            (const int32_t(*)[3])mesh->triangle, 0, NULL, &cut,
                                            NULL),
                             SOFTSIM_OK);
            ss_mesh_destroy(&mesh);
            mesh = cut;
        }
        assert_int_equal(ss_mesh_write_obj(mesh, in_folder(names[0]), NULL), SOFTSIM_OK);
        assert_int_equal(ss_mesh_write_msh(mesh, in_folder(names[1]), NULL), SOFTSIM_OK);
        assert_int_equal(ss_mesh_write_vtk(mesh, in_folder(names[2]), NULL), SOFTSIM_OK);
        for (int i = 0; i < 3; ++i) {
            ss_mesh *back = load(in_folder(names[i]), 1.0);
            expect_same(back, mesh);
            ss_mesh_destroy(&back);
        }
        ss_mesh_destroy(&mesh);
    }
    softsim_error error = {0};
    ss_mesh *mesh = make_reference();
    assert_int_equal(ss_mesh_write_vtk(mesh, in_folder("no/folder.vtk"), &error),
                     SOFTSIM_ERROR_FILE);
    assert_int_equal(error.fault_count, 1);
    ss_mesh_destroy(&mesh);
}

/* ---- long lines ---- */

TEST(a_line_that_exceeds_the_window_is_refused)
{
    FILE *file = open_file("long.msh");
    (void)fputs("$Comments\n", file);
    for (int i = 0; i < SS_TEXT_WINDOW; ++i) {
        (void)fputc('x', file);
    }
    (void)fputs("\n$EndComments\n", file);
    assert_int_equal(fclose(file), 0);
    ss_mesh *mesh = NULL;
    softsim_error error = {0};
    assert_int_equal(ss_mesh_load(in_folder("long.msh"), 1.0, importer, &mesh, &error),
                     SOFTSIM_ERROR_FORMAT);
    assert_null(mesh);
    assert_non_null(strstr(error.text, "without an end of line"));
    assert_int_equal(error.fault_count, 1);
}

int main(void)
{
    return run_all_tests(make_block, remove_folder);
}
