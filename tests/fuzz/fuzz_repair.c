/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * libFuzzer over the repair of meshes. The input is a list of words: the first make closed
 * surfaces, or blocks of tetrahedra; the others damage them. What comes out must be taken by a
 * scene (open edges and crossings are told, not refused), or be refused with a reason; repaired
 * again it must stay as it is; its groups must be sound; and a damage that only doubles, turns or
 * scatters must be undone whole.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh.h"
#include "rt/memory.h"
#include "rt/vec.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { NODES = 3000, FACES = 3000, TETRAHEDRA = 600 };

typedef struct body {
    double x[NODES][3];
    int32_t face[FACES][3], tetrahedron[TETRAHEDRA][4];
    int32_t nodes, faces, tetrahedra, parts;
    bool is_wounded; /* by more than doubling, turning and scattering */
} body;

static void require(bool holds)
{
    if (!holds) {
        abort();
    }
}

typedef struct words {
    const uint8_t *data;
    size_t size;
} words;

static uint32_t take(words *w)
{
    const uint32_t value = w->size > 0 ? *w->data : 0;
    w->data += w->size > 0;
    w->size -= w->size > 0;
    return value;
}

static uint32_t take_two(words *w)
{
    const uint32_t high = take(w);
    return high << 8 | take(w);
}

static double take_share(words *w)
{
    return (double)take(w) / 256.0;
}

static int32_t add_node(body *b, const double x[3])
{
    if (b->nodes == NODES) {
        return NODES - 1;
    }
    ss_copy3(b->x[b->nodes], x);
    return b->nodes++;
}

static void add_face(body *b, int32_t i, int32_t j, int32_t k)
{
    if (b->faces < FACES) {
        const int32_t face[3] = {i, j, k};
        memcpy(b->face[b->faces++], face, sizeof face);
    }
}

/* A closed surface of rings: a ball with poles, or a torus. */
static void add_surface(body *b, words *w)
{
    const int around = 3 + (int)(take(w) % 10), rings = 2 + (int)(take(w) % 8);
    const bool is_torus = take(w) % 4 == 0;
    double middle[3];
    for (int k = 0; k < 3; ++k) {
        middle[k] = floor(8.0 * take_share(w));
    }
    const double size = 0.5 + 2.0 * take_share(w);
    const int32_t at = b->nodes;
    const int count = is_torus ? rings + 1 : rings;
    for (int r = 0; r < count; ++r) {
        for (int a = 0; a < around; ++a) {
            const double u = 2.0 * SS_PI * a / around;
            const double v = is_torus ? 2.0 * SS_PI * r / count : SS_PI * (r + 1) / (count + 1);
            const double radius = is_torus ? 1.0 + 0.4 * cos(v) : sin(v);
            double x[3] = {radius * cos(u), radius * sin(u), is_torus ? 0.4 * sin(v) : -cos(v)};
            ss_madd3(x, middle, size, x);
            (void)add_node(b, x);
        }
    }
    for (int r = 0; r + (is_torus ? 0 : 1) < count; ++r) {
        for (int a = 0; a < around; ++a) {
            const int32_t i = at + r * around + a, j = at + r * around + (a + 1) % around;
            const int32_t up = (r + 1) % count * around - r * around;
            add_face(b, i, j, j + up);
            add_face(b, i, j + up, i + up);
        }
    }
    for (int end = 0; end < 2 && !is_torus; ++end) {
        const double pole[3] = {middle[0], middle[1], middle[2] + (end == 0 ? -size : size)};
        const int32_t tip = add_node(b, pole), ring = at + (end == 0 ? 0 : (count - 1) * around);
        for (int a = 0; a < around; ++a) {
            const int32_t i = ring + a, j = ring + (a + 1) % around;
            add_face(b, end == 0 ? j : i, end == 0 ? i : j, tip);
        }
    }
    ++b->parts;
}

static void add_block(body *b, words *w)
{
    static const int32_t kuhn[6][4] = {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7},
                                       {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}};
    const int n = 1 + (int)(take(w) % 4);
    for (int i = 0; i < (n + 1) * (n + 1) * (n + 1); ++i) {
        const int row = i / (n + 1), layer = row / (n + 1);
        const double x[3] = {i % (n + 1), row % (n + 1), layer};
        (void)add_node(b, x);
    }
    for (int i = 0; i < n * n * n; ++i) {
        const int row = i / n, layer = row / n;
        const int32_t at = i % n + (n + 1) * (row % n) + (n + 1) * (n + 1) * layer;
        for (int e = 0; e < 6 && b->tetrahedra < TETRAHEDRA - 8; ++e) {
            int32_t *node = b->tetrahedron[b->tetrahedra++];
            for (int k = 0; k < 4; ++k) {
                const int32_t c = kuhn[e][k];
                node[k] = at + (c & 1) + (n + 1) * (c >> 1 & 1) + (n + 1) * (n + 1) * (c >> 2);
            }
        }
    }
}

/* Where a face's node is; of one that does not exist, the first. */
static const double *place_of(const body *b, int32_t node)
{
    return b->x[node >= 0 && node < b->nodes ? node : 0];
}

static void damage(body *b, words *w)
{
    const uint32_t kind = take(w) % 14;
    const int32_t f = (int32_t)(take_two(w) % (uint32_t)(b->faces > 0 ? b->faces : 1));
    const int32_t i = (int32_t)(take_two(w) % (uint32_t)b->nodes);
    int32_t *face = b->face[f];
    int32_t *other = b->face[take_two(w) % (uint32_t)(b->faces > 0 ? b->faces : 1)];
    double x[3];
    ss_copy3(x, b->x[i]);
    b->is_wounded = b->is_wounded || kind > 2;
    switch (kind) {
    case 0: /* turned */
        x[0] = face[1];
        face[1] = face[2];
        face[2] = (int32_t)x[0];
        break;
    case 1: /* there twice */
        add_face(b, face[1], face[2], face[0]);
        break;
    case 2: /* a node of its own */
        ss_copy3(x, place_of(b, face[0]));
        if (b->nodes < NODES) {
            face[0] = add_node(b, x);
        }
        break;
    case 3: /* gone */
        memcpy(face, b->face[b->faces > 0 ? --b->faces : 0], sizeof b->face[0]);
        break;
    case 4: /* nodes joined: pinches, edges of many, flats */
        face[0] = other[1];
        break;
    case 5: /* all of one node */
        for (int32_t k = 0; k < 3 * b->faces; ++k) {
            b->face[k / 3][k % 3] = b->face[k / 3][k % 3] == i ? other[0] : b->face[k / 3][k % 3];
        }
        break;
    case 6: /* a face across */
        add_face(b, face[0], face[1], other[2]);
        break;
    case 7: /* a flap */
        x[0] += take_share(w);
        add_face(b, face[0], face[1], add_node(b, x));
        break;
    case 8: /* divided on one side */
        ss_add3(x, place_of(b, face[0]), place_of(b, face[1]));
        ss_scale3(x, x, 0.5);
        if (b->nodes < NODES && b->faces < FACES) {
            const int32_t middle = add_node(b, x);
            add_face(b, middle, face[1], face[2]);
            face[1] = middle;
        }
        break;
    case 9: /* moved */
        b->x[i][take(w) % 3] += 4.0 * take_share(w) - 2.0;
        break;
    case 10: /* near another */
        ss_copy3(b->x[i], place_of(b, other[0]));
        b->x[i][0] += ldexp(1.0, -(int)(take(w) % 50));
        break;
    case 11: /* no number */
        b->x[i][0] = take(w) % 2 == 0 ? (double)INFINITY : (double)NAN;
        break;
    case 12: /* no node */
        face[2] = take(w) % 2 == 0 ? -1 : NODES + 5;
        break;
    default:
        if (b->tetrahedra > 0 && b->tetrahedra < TETRAHEDRA) {
            int32_t *node = b->tetrahedron[take_two(w) % (uint32_t)b->tetrahedra];
            node[take(w) % 4] = i;
            memcpy(b->tetrahedron[b->tetrahedra++], node, sizeof b->tetrahedron[0]);
        }
    }
}

static void name_group(ss_mesh *mesh)
{
    mesh->group = ss_memory_get(1, sizeof *mesh->group);
    require(mesh->group != NULL);
    mesh->group[0].node = ss_memory_get((size_t)mesh->node_count, sizeof(int32_t));
    require(mesh->group[0].node != NULL);
    strcpy(mesh->group[0].name, "every third");
    mesh->group_count = 1;
    for (int32_t i = 0; i < mesh->node_count; i += 3) {
        mesh->group[0].node[mesh->group[0].node_count++] = i;
    }
}

static bool is_same(const ss_mesh *a, const ss_mesh *b)
{
    return a->node_count == b->node_count && a->triangle_count == b->triangle_count &&
           a->tetrahedron_count == b->tetrahedron_count &&
           memcmp(a->position, b->position, (size_t)a->node_count * sizeof *a->position) == 0 &&
           memcmp(a->triangle, b->triangle, (size_t)a->triangle_count * sizeof *a->triangle) == 0;
}

static void examine(const body *b, ss_mesh *mesh)
{
    softsim_error error = {0};
    ss_mesh_repairs done, nothing = {0};
    ss_mesh_report before, r;
    ss_mesh *mended = NULL, *again = NULL;
    require(ss_mesh_check(mesh, &before) == SOFTSIM_OK);
    const softsim_status status = ss_mesh_repair(mesh, &mended, &done, &error);
    require((status == SOFTSIM_OK) == (mended != NULL));
    require(status == SOFTSIM_OK || error.fault_count > 0);
    if (mended == NULL) {
        require(b->is_wounded);
        return;
    }
    require(ss_mesh_check(mended, &r) == SOFTSIM_OK);
    if (mended->tetrahedron_count == 0) {
        ss_mesh_finding found[SS_MESH_MAX_FINDINGS];
        const int32_t count = ss_mesh_list_findings(mended, &r, found);
        for (int32_t i = 0; i < count; ++i) {
            require(found[i].is_harmless);
        }
        require(!r.is_inside_out);
    }
    require(b->is_wounded || b->tetrahedra > 0 || mended->is_closed);
    require(ss_mesh_repair(mended, &again, &nothing, &error) == SOFTSIM_OK);
    require(is_same(mended, again));
    for (int32_t g = 0; g < mended->group_count; ++g) {
        for (int32_t i = 0; i < mended->group[g].node_count; ++i) {
            require(mended->group[g].node[i] >= 0 && mended->group[g].node[i] < mended->node_count);
        }
    }
    ss_mesh_destroy(&again);
    ss_mesh_destroy(&mended);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static body b;
    words w = {data, size};
    b.nodes = b.faces = b.tetrahedra = b.parts = 0;
    b.is_wounded = false;
    const uint32_t bodies = take(&w);
    for (uint32_t i = 0; i <= bodies % 4; ++i) {
        if (bodies >= 240) {
            add_block(&b, &w);
            b.is_wounded = true;
            break;
        }
        add_surface(&b, &w);
    }
    /* Bodies may lie on each other. */
    b.is_wounded = b.is_wounded || b.parts > 1;
    while (w.size > 0) {
        damage(&b, &w);
    }
    softsim_error error = {0};
    ss_mesh *mesh = NULL;
    const bool is_volume = b.tetrahedra > 0;
    if (ss_mesh_create(b.nodes, (const double(*)[3])b.x, is_volume ? 0 : b.faces,
                       (const int32_t(*)[3])b.face, b.tetrahedra,
                       (const int32_t(*)[4])b.tetrahedron, &mesh, &error) == SOFTSIM_OK) {
        name_group(mesh);
        examine(&b, mesh);
        ss_mesh_destroy(&mesh);
    }
    require(ss_memory_in_use() == 0);
    return 0;
}
