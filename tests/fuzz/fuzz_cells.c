/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer over the splitting of cells: two layers of two by two cubes, whose corners the input
 * numbers, moves and merges along edges, and of which it makes a hexahedron, six pyramids, two
 * prisms, or nothing.
 *
 * Of each cell the pieces must fill what its faces enclose, each cut from its lowest node; cells
 * that are told to be folded are left out. Where nothing was merged, the surface of all pieces must
 * be that of the cells, two triangles for each square that one cell has: they conform. The mesh
 * then goes through all that readers' meshes go through.
 */
#include "fuzz_mesh.h"

#include "mesh/cells.h"
#include "mesh/topology.h"
#include "rt/vec.h"

enum { N = 2, CORNERS = 27, NODES = CORNERS + 8, MOST = 12 * 8, MOST_FACES = 6 * 8 * 6 };

typedef struct block {
    const uint8_t *data;
    size_t size;
    double position[NODES][3];
    int32_t number[NODES];
    int32_t tetrahedron[MOST][4];
    int32_t count;
    int32_t face[MOST_FACES][4]; /* ascending; of triangles the first is -1 */
    int32_t face_count;
} block;

static uint8_t take(block *b)
{
    if (b->size == 0) {
        return 0;
    }
    --b->size;
    return *b->data++;
}

static const int8_t hexahedron[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                        {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
static const int8_t prism[5][4] = {
    {0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
static const int8_t pyramid[5][4] = {
    {0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}};

static double cone(const block *b, int32_t i, int32_t j, int32_t k)
{
    const double origin[3] = {0.0, 0.0, 0.0};
    return ss_six_volumes3(origin, b->position[i], b->position[j], b->position[k]);
}

static int compare_ints(const void *left, const void *right)
{
    const int32_t a = *(const int32_t *)left, b = *(const int32_t *)right;
    return (a > b) - (a < b);
}

/* Six volumes of what the faces enclose; lists them. */
static double enclose(block *b, const int8_t (*face)[4], int faces, const int32_t *node)
{
    double sum = 0.0;
    for (int f = 0; f < faces; ++f) {
        const int corners = face[f][3] < 0 ? 3 : 4;
        int32_t v[4] = {-1, -1, -1, -1};
        int first = 0;
        for (int k = 0; k < corners; ++k) {
            v[k] = node[face[f][k]];
            first = v[k] < v[first] ? k : first;
        }
        for (int k = 1; k + 1 < corners; ++k) {
            sum += cone(b, v[first], v[(first + k) % corners], v[(first + k + 1) % corners]);
        }
        qsort(v, 4, sizeof *v, compare_ints);
        memcpy(b->face[b->face_count++], v, sizeof v);
    }
    return sum;
}

static void add(block *b, ss_mesh_kind kind, const int8_t (*face)[4], int faces,
                const int32_t *node)
{
    int32_t piece[SS_CELL_PIECES][4];
    const int32_t before = b->face_count;
    const int count = ss_mesh_split_cell(kind, (const double(*)[3])b->position, node, piece);
    const double whole = fabs(enclose(b, face, faces, node));
    require(count <= ss_mesh_cell_pieces(kind));
    double sum = 0.0;
    for (int p = 0; p < count; ++p) {
        const int32_t *t = piece[p];
        for (int k = 0; k < 4; ++k) {
            require(t[k] >= 0 && t[k] < NODES);
            for (int j = 0; j < k; ++j) {
                require(t[k] != t[j]);
            }
        }
        const double v = ss_six_volumes3(b->position[t[0]], b->position[t[1]], b->position[t[2]],
                                         b->position[t[3]]);
        require(v > -1e-9);
        sum += v;
    }
    if (count <= 0) {
        b->face_count = before;
        return;
    }
    require(fabs(sum - whole) < 1e-9);
    memcpy(b->tetrahedron[b->count], piece, (size_t)count * sizeof *piece);
    b->count += count;
}

static int diagonal(const int32_t *node)
{
    int lowest = 0;
    for (int k = 1; k < 4; ++k) {
        lowest = node[k] < node[lowest] ? k : lowest;
    }
    return lowest % 2;
}

static void add_prisms(block *b, const int32_t c[8])
{
    const int d = diagonal(c), e = (3 + d) % 4;
    const int32_t one[6] = {c[d], c[1 + d], c[2 + d], c[4 + d], c[5 + d], c[6 + d]};
    const int32_t two[6] = {c[d], c[2 + d], c[e], c[4 + d], c[6 + d], c[4 + e]};
    add(b, SS_MESH_PRISM, prism, 5, one);
    add(b, SS_MESH_PRISM, prism, 5, two);
}

static void add_pyramids(block *b, const int32_t c[8], int32_t middle)
{
    ss_set3(b->position[middle], 0.0, 0.0, 0.0);
    for (int k = 0; k < 8; ++k) {
        ss_madd3(b->position[middle], b->position[middle], 0.125, b->position[c[k]]);
    }
    for (int f = 0; f < 6; ++f) {
        /* The apex is inside: bases wind the other way than faces. */
        const int8_t *s = hexahedron[f];
        const int32_t node[5] = {c[s[3]], c[s[2]], c[s[1]], c[s[0]], middle};
        add(b, SS_MESH_PYRAMID, pyramid, 5, node);
    }
}

/* Returns how many cells have prisms, whose ends need not fit a neighbour. */
static int fill(block *b)
{
    int prisms = 0;
    for (int i = 0; i < N * N * N; ++i) {
        int32_t c[8];
        for (int k = 0; k < 8; ++k) {
            const int x = i % 2 + ((k & 3) == 1 || (k & 3) == 2), y = i / 2 % 2 + ((k & 3) >= 2);
            c[k] = b->number[((i / 4 + k / 4) * 3 + y) * 3 + x];
        }
        switch (take(b) & 3) {
        case 0:
            add(b, SS_MESH_HEXAHEDRON, hexahedron, 6, c);
            break;
        case 1:
            add_pyramids(b, c, b->number[CORNERS + i]);
            break;
        case 2:
            add_prisms(b, c);
            ++prisms;
            break;
        default:
            break;
        }
    }
    return prisms;
}

static int compare_faces(const void *left, const void *right)
{
    return memcmp(left, right, sizeof(int32_t[4]));
}

/* Triangles of the cells' faces that one cell alone has. */
static int32_t outside(block *b)
{
    int32_t count = 0;
    qsort(b->face, (size_t)b->face_count, sizeof *b->face, compare_faces);
    for (int32_t f = 0; f < b->face_count; ++f) {
        const bool is_shared =
            (f > 0 && compare_faces(b->face[f], b->face[f - 1]) == 0) ||
            (f + 1 < b->face_count && compare_faces(b->face[f], b->face[f + 1]) == 0);
        count += is_shared ? 0 : b->face[f][0] < 0 ? 1 : 2;
    }
    return count;
}

/* Leaves out the nodes that no tetrahedron has; returns how many are left. */
static int32_t close_up(block *b)
{
    memset(b->number, 0, sizeof b->number);
    for (int32_t e = 0; e < b->count; ++e) {
        for (int k = 0; k < 4; ++k) {
            b->number[b->tetrahedron[e][k]] = 1;
        }
    }
    int32_t left = 0;
    for (int32_t i = 0; i < NODES; ++i) {
        if (b->number[i] != 0) {
            memmove(b->position[left], b->position[i], sizeof b->position[i]);
            b->number[i] = left++;
        }
    }
    for (int32_t e = 0; e < b->count; ++e) {
        for (int k = 0; k < 4; ++k) {
            b->tetrahedron[e][k] = b->number[b->tetrahedron[e][k]];
        }
    }
    return left;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static block b;
    b = (block){.data = data, .size = size};
    for (int32_t i = 0; i < NODES; ++i) {
        b.number[i] = i;
    }
    for (int32_t i = NODES - 1; i > 0; --i) {
        const int32_t k = take(&b) % (i + 1), swap = b.number[i];
        b.number[i] = b.number[k];
        b.number[k] = swap;
    }
    for (int32_t i = 0; i < CORNERS; ++i) {
        const double at[3] = {i % 3, i / 3 % 3, i / 9};
        for (int k = 0; k < 3; ++k) {
            b.position[b.number[i]][k] = at[k] + (int8_t)take(&b) / 256.0;
        }
    }
    const int merges = take(&b) & 3;
    for (int m = 0; m < merges; ++m) {
        const int32_t i = take(&b) % CORNERS;
        const int32_t k = i % 3 < 2 ? i + 1 : i - 1;
        b.number[i] = b.number[k];
    }
    const int prisms = fill(&b);
    if (b.count > 0) {
        ss_mesh *mesh = NULL;
        softsim_error error = {0};
        const int32_t faces = outside(&b), nodes = close_up(&b);
        require(ss_mesh_create(nodes, (const double(*)[3])b.position, 0, NULL, b.count,
                               (const int32_t(*)[4])b.tetrahedron, &mesh, &error) == SOFTSIM_OK);
        require(merges > 0 || prisms > 0 || mesh->triangle_count == faces);
        examine(SOFTSIM_OK, mesh, &error);
    }
    return 0;
}
