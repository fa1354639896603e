/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Hexahedra, prisms and pyramids as tetrahedra. A block of n^3 cubes, each left whole, cut into two
 * prisms or into six pyramids about its middle, has its nodes moved a little and numbered at
 * random; whatever the numbers, the tetrahedra fill the block once (volume, none inverted) and
 * conform (every face has two of them, but the block's own, which are two for each square).
 */
#include "common/test.h"

#include <string.h>

#include "common/mesh_fixture.h"
#include "mesh/cells.h"
#include "mesh/mesh.h"
#include "rt/random.h"
#include "rt/vec.h"

enum { N = 3, CORNERS = (N + 1) * (N + 1) * (N + 1), NODES = CORNERS + N * N * N, MOST = 12 };

typedef struct block {
    int32_t number[NODES]; /* of corners by place, then of middles */
    double position[NODES][3];
    int32_t tetrahedron[MOST * N * N * N][4];
    int32_t node_count, count;
} block;

static double draw(uint64_t *random)
{
    return (double)(ss_random_next(random) >> 11) / 9007199254740992.0;
}

static int32_t corner(int x, int y, int z)
{
    return (z * (N + 1) + y) * (N + 1) + x;
}

static void number_at_random(block *b, uint64_t *random)
{
    for (int32_t i = 0; i < NODES; ++i) {
        b->number[i] = i;
    }
    for (int32_t i = NODES - 1; i > 0; --i) {
        const int32_t k = (int32_t)(ss_random_next(random) % (uint64_t)(i + 1));
        const int32_t swap = b->number[i];
        b->number[i] = b->number[k];
        b->number[k] = swap;
    }
}

/* Corners within the block are moved along one axis each by up to `most`, and the block's outside
 * stays: a cube's volume then is not 1, but all together are N^3. */
static void place(block *b, double most, uint64_t *random)
{
    for (int32_t i = 0; i < CORNERS; ++i) {
        double *x = b->position[b->number[i]];
        const int at[3] = {i % (N + 1), i / (N + 1) % (N + 1), i / (N + 1) / (N + 1)};
        for (int k = 0; k < 3; ++k) {
            const bool is_inner = at[k] > 0 && at[k] < N;
            x[k] = at[k] + (is_inner ? most * (2.0 * draw(random) - 1.0) : 0.0);
        }
    }
}

static void add(block *b, ss_mesh_kind kind, const int32_t *node)
{
    int32_t piece[SS_CELL_PIECES][4];
    const int count = ss_mesh_split_cell(kind, (const double(*)[3])b->position, node, piece);
    assert_int_equal(count, ss_mesh_cell_pieces(kind));
    memcpy(b->tetrahedron[b->count], piece, (size_t)count * sizeof *piece);
    b->count += count;
}

static void add_pyramids(block *b, const int32_t c[8], int32_t middle)
{
    static const int8_t base[6][4] = {{0, 1, 2, 3}, {7, 6, 5, 4}, {4, 5, 1, 0},
                                      {5, 6, 2, 1}, {6, 7, 3, 2}, {7, 4, 0, 3}};
    double *x = b->position[middle];
    ss_set3(x, 0.0, 0.0, 0.0);
    for (int k = 0; k < 8; ++k) {
        ss_madd3(x, x, 0.125, b->position[c[k]]);
    }
    for (int f = 0; f < 6; ++f) {
        const int8_t *s = base[f];
        const int32_t node[5] = {c[s[0]], c[s[1]], c[s[2]], c[s[3]], middle};
        add(b, SS_MESH_PYRAMID, node);
    }
}

/* Which diagonal a square is cut along: the one from its lowest node. */
static int diagonal(const int32_t *node)
{
    int lowest = 0;
    for (int k = 1; k < 4; ++k) {
        lowest = node[k] < node[lowest] ? k : lowest;
    }
    return lowest % 2;
}

/* Two prisms, whose ends are triangles and must fit the neighbours' squares. */
static void add_prisms(block *b, const int32_t c[8])
{
    const int d = diagonal(c);
    const int32_t one[6] = {c[d], c[1 + d], c[2 + d], c[4 + d], c[5 + d], c[6 + d]};
    const int e = (3 + d) % 4;
    const int32_t two[6] = {c[d], c[2 + d], c[e], c[4 + d], c[6 + d], c[4 + e]};
    add(b, SS_MESH_PRISM, one);
    add(b, SS_MESH_PRISM, two);
}

static void fill(block *b, uint64_t *random)
{
    b->count = 0;
    for (int i = 0; i < N * N * N; ++i) {
        const int x = i % N, y = i / N % N, z = i / N / N;
        int32_t c[8];
        for (int k = 0; k < 8; ++k) {
            const int along = (k & 3) == 1 || (k & 3) == 2, up = (k & 3) >= 2;
            c[k] = b->number[corner(x + along, y + up, z + k / 4)];
        }
        const uint64_t choice = ss_random_next(random) % 3;
        if (choice == 0) {
            add_pyramids(b, c, b->number[CORNERS + i]);
        } else if (choice == 1 && diagonal(c) == diagonal(c + 4)) {
            add_prisms(b, c);
        } else {
            add(b, SS_MESH_HEXAHEDRON, c);
        }
    }
}

TEST(cells_of_any_numbers_conform_and_fill_a_block_once)
{
    uint64_t random = 1999;
    for (int round = 0; round < 100; ++round) {
        static block b;
        ss_mesh_report r;
        number_at_random(&b, &random);
        place(&b, 0.15, &random);
        fill(&b, &random);
        ss_mesh *m = make_mesh(NODES, (const double(*)[3])b.position, 0, NULL, b.count,
                               (const int32_t(*)[4])b.tetrahedron);
        assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
        assert_int_equal(r.inverted_tetrahedron.count + r.flat_tetrahedron.count, 0);
        assert_int_equal(r.crowded_face.count + r.pinched_edge.count + r.pinched_node.count, 0);
        assert_true(m->is_closed);
        assert_int_equal(m->triangle_count, 2 * 6 * N * N);
        assert_near(r.volume, N * N * N, 1e-12 * N * N * N);
        double volume = 0.0;
        for (int32_t e = 0; e < b.count; ++e) {
            const int32_t *t = b.tetrahedron[e];
            volume += ss_six_volumes3(b.position[t[0]], b.position[t[1]], b.position[t[2]],
                                      b.position[t[3]]) /
                      6.0;
        }
        assert_near(volume, N * N * N, 1e-12 * N * N * N);
        ss_mesh_destroy(&m);
    }
}

/* A unit cube with nodes of its own. */
static const double cube[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                  {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

static double volume_of(int count, int32_t (*piece)[4])
{
    double volume = 0.0;
    for (int p = 0; p < count; ++p) {
        const double v = ss_six_volumes3(cube[piece[p][0]], cube[piece[p][1]], cube[piece[p][2]],
                                         cube[piece[p][3]]);
        assert_true(v > 0.0);
        volume += v / 6.0;
    }
    return volume;
}

TEST(cells_that_run_the_other_way_round_are_turned)
{
    static const int32_t hexahedron[] = {4, 5, 6, 7, 0, 1, 2, 3}, prism[] = {0, 2, 1, 4, 6, 5},
                         pyramid[] = {3, 2, 1, 0, 4};
    int32_t piece[SS_CELL_PIECES][4];
    assert_int_equal(ss_mesh_split_cell(SS_MESH_HEXAHEDRON, cube, hexahedron, piece), 6);
    assert_near(volume_of(6, piece), 1.0, 1e-15);
    assert_int_equal(ss_mesh_split_cell(SS_MESH_PRISM, cube, prism, piece), 3);
    assert_near(volume_of(3, piece), 0.5, 1e-15);
    assert_int_equal(ss_mesh_split_cell(SS_MESH_PYRAMID, cube, pyramid, piece), 2);
    assert_near(volume_of(2, piece), 1.0 / 3.0, 1e-15);
}

/* Hexahedra with a side, a face's corner or an edge in one node: a prism, a pyramid, and so on. */
TEST(collapsed_cells_lose_the_pieces_that_have_no_volume)
{
    static const struct {
        int32_t node[8];
        int count;
        double volume;
    } cells[] = {{{0, 1, 2, 2, 4, 5, 6, 6}, 3, 0.5},       {{2, 2, 0, 1, 6, 6, 4, 5}, 3, 0.5},
                 {{0, 1, 2, 3, 4, 4, 4, 4}, 2, 1.0 / 3.0}, {{4, 4, 4, 4, 3, 2, 1, 0}, 2, 1.0 / 3.0},
                 {{0, 1, 2, 2, 4, 4, 4, 4}, 1, 1.0 / 6.0}, {{0, 0, 0, 0, 0, 0, 0, 0}, 0, 0.0},
                 {{0, 1, 2, 3, 0, 1, 2, 3}, 0, 0.0}};
    for (size_t i = 0; i < sizeof cells / sizeof *cells; ++i) {
        int32_t piece[SS_CELL_PIECES][4];
        const int count = ss_mesh_split_cell(SS_MESH_HEXAHEDRON, cube, cells[i].node, piece);
        assert_int_equal(count, cells[i].count);
        assert_near(volume_of(count, piece), cells[i].volume, 1e-15);
    }
}

TEST(folded_cells_are_told)
{
    static const int32_t hexahedron[] = {0, 1, 3, 2, 4, 5, 6, 7}, prism[] = {0, 1, 2, 5, 4, 6};
    int32_t piece[SS_CELL_PIECES][4];
    assert_int_equal(ss_mesh_split_cell(SS_MESH_HEXAHEDRON, cube, hexahedron, piece), -1);
    assert_int_equal(ss_mesh_split_cell(SS_MESH_PRISM, cube, prism, piece), -1);
    assert_int_equal(ss_mesh_cell_pieces(SS_MESH_TETRAHEDRON), 0);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
