/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * The network's templates on triangles, rectangular grids and tetrahedra: the printed formulas,
 * patch tests, materials with a direction, and the columns against a dense solve.
 */
#include "common/test.h"

#include "common/element_fixture.h"
#include "rt/thread.h"

/* ---- helpers ---- */

/* A network whose rho is uniform unless the fabric says otherwise; nothing is held but `held`. */
static ss_cnn_network *network_of(const ss_cnn_fabric *fabric, const uint8_t *held)
{
    ss_cnn_network *network = NULL;
    softsim_error error = {0};
    const size_t n = (size_t)fabric->mesh->node_count;
    double *rho = calloc(n, sizeof *rho);
    uint8_t *none = calloc(n, 1);
    ss_cnn_fabric full = *fabric;
    for (size_t i = 0; i < n; ++i) {
        rho[i] = 1.0;
    }
    full.rho = fabric->rho ? fabric->rho : rho;
    if (ss_cnn_network_create(&full, held ? held : none, &network, &error) != SOFTSIM_OK) {
        fail_msg("network: %s", error.text);
    }
    free(rho);
    free(none);
    return network;
}

static int32_t edge_between(const ss_cnn_network *network, int32_t i, int32_t j)
{
    for (int32_t e = 0; e < network->edges.count; ++e) {
        if (network->edges.from[e] == 4 * (i < j ? i : j) &&
            network->edges.to[e] == 4 * (i < j ? j : i)) {
            return e;
        }
    }
    return -1;
}

static double harmonic(double a, double b)
{
    return 2.0 * a * b / (a + b);
}

/* D = sum_j c_ij e e^T / (2 S_i), the second moment of a cell's template (1 where the Laplacian is
 * consistent), and |sum_j c_ij e| / sum_j c_ij |e|, what it makes of a linear potential. */
static double moments_of(const ss_cnn_network *network, const ss_mesh *mesh, int32_t cell,
                         double d[3][3])
{
    double sum[3] = {0.0, 0.0, 0.0}, scale = 0.0;
    memset(d, 0, 9 * sizeof(double));
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
        if (i != cell && j != cell) {
            continue;
        }
        double arm[3];
        ss_sub3(arm, mesh->position[i == cell ? j : i], mesh->position[cell]);
        ss_madd3(sum, sum, network->edge_weight[e], arm);
        scale += network->edge_weight[e] * ss_norm3(arm);
        for (int a = 0; a < 3; ++a) {
            ss_madd3(d[a], d[a], network->edge_weight[e] * arm[a] / (2.0 * network->size[cell]),
                     arm);
        }
    }
    return ss_norm3(sum) / scale;
}

/* ---- templates as printed ---- */

TEST(the_hexagon_fan_has_the_printed_template)
{
    const double h = 0.3;
    ss_mesh *mesh = make_fan(h);
    const uint8_t held[7] = {0, 1, 1, 1, 1, 1, 1};
    double rho[7], kap[16];
    const ss_cnn_fabric fabric = {.mesh = mesh, .element = SS_CNN_TRIANGLE, .rho = rho};
    const int32_t centre = 0;
    const double one = 1.0;
    for (int k = 0; k < 7; ++k) {
        rho[k] = 0.05;
    }
    ss_cnn_network *network = network_of(&fabric, held);
    assert_near(network->edge_weight[edge_between(network, 0, 1)], 1.0 / sqrt(3.0), 1e-12);
    assert_near(network->edge_weight[edge_between(network, 1, 2)], 0.5 / sqrt(3.0),
                1e-12); /* rim */
    assert_near(network->size[0], sqrt(3.0) * h * h / 2.0, 1e-12);
    assert_ptr_equal(network->size, network->surface_area);
    assert_int_equal(ss_cnn_network_superpose(network, 1, &centre, &one, kap), SOFTSIM_OK);
    assert_near(network->own[0], h * h / (4.0 * 0.05), 1e-12);
    assert_near(network->qhat[0], 1.5 * h * h, 1e-12);
    assert_near(kap[edge_between(network, 0, 4)], 0.25 / (1.5 * h * h), 1e-12);
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
}

TEST(a_tensor_grid_has_the_printed_template)
{
    enum { ROWS = 5, COLUMNS = 6 };
    static const double x[ROWS] = {0.0, 0.3, 0.35, 1.0, 1.2};
    static const double y[COLUMNS] = {-1.0, -0.8, -0.1, 0.0, 0.7, 0.75};
    ss_mesh *mesh = make_tensor_grid(ROWS, COLUMNS, x, y);
    ss_cnn_network *network =
        network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_QUAD}, NULL);
    assert_int_equal(network->edges.count, (ROWS - 1) * COLUMNS + ROWS * (COLUMNS - 1));
    for (int n = 0; n < ROWS * COLUMNS; ++n) {
        const int i = n / COLUMNS, j = n % COLUMNS; /* steps to both sides, 0 beyond the border */
        const double du = i + 1 < ROWS ? x[i + 1] - x[i] : 0.0,
                     du_before = i > 0 ? x[i] - x[i - 1] : 0.0;
        const double dw = j + 1 < COLUMNS ? y[j + 1] - y[j] : 0.0;
        const double dw_before = j > 0 ? y[j] - y[j - 1] : 0.0;
        assert_near(network->size[n], (du + du_before) * (dw + dw_before) / 4.0, 1e-12);
        if (du > 0.0) {
            const int32_t e = edge_between(network, n, n + COLUMNS);
            assert_near(network->edge_weight[e], (dw_before + dw) / (2.0 * du), 1e-12);
        }
        if (dw > 0.0) {
            const int32_t e = edge_between(network, n, n + 1);
            assert_near(network->edge_weight[e], (du_before + du) / (2.0 * dw), 1e-12);
        }
        assert_int_equal(edge_between(network, n, n + COLUMNS + 1), -1); /* no diagonals */
    }
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
}

/* Equation 14 at one end: half the transverse steps there over the length. */
static double one_sided(const ss_mesh *mesh, int32_t at, int32_t to, int32_t left, int32_t right)
{
    double length[3], side[2][3];
    ss_sub3(length, mesh->position[to], mesh->position[at]);
    ss_sub3(side[0], mesh->position[left], mesh->position[at]);
    ss_sub3(side[1], mesh->position[right], mesh->position[at]);
    return 0.5 * (ss_norm3(side[0]) + ss_norm3(side[1])) / ss_norm3(length);
}

TEST(a_distorted_grid_takes_the_mean_of_both_ends)
{
    enum { SIDE = 5 };
    double position[SIDE * SIDE][3];
    random_state = 11;
    for (int n = 0; n < SIDE * SIDE; ++n) {
        ss_set3(position[n], n / SIDE + 0.2 * random_unit(), n % SIDE + 0.2 * random_unit(),
                0.3 * random_unit());
    }
    ss_mesh *mesh = make_grid(SIDE, SIDE, false, (const double(*)[3])position);
    ss_cnn_network *network =
        network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_QUAD}, NULL);
    for (int i = 1; i < SIDE - 2; ++i) {
        for (int j = 1; j < SIDE - 1; ++j) {
            const int32_t a = i * SIDE + j, b = a + SIDE;
            const double here = one_sided(mesh, a, b, a - 1, a + 1);
            const double there = one_sided(mesh, b, a, b - 1, b + 1);
            assert_true(fabs(here - there) > 1e-4);
            assert_near(network->edge_weight[edge_between(network, a, b)], 0.5 * (here + there),
                        1e-12);
        }
    }
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
}

TEST(an_edge_in_a_volume_has_its_dual_face)
{
    /* The ball fan: D from its four corners, one by one; V a quarter of the star. */
    const double h = 0.4;
    ss_mesh *mesh = make_ball_fan(h);
    ss_cnn_network *network =
        network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_TETRAHEDRON}, NULL);
    double dual = 0.0, star = 0.0;
    for (int32_t t = 0; t < mesh->tetrahedron_count; ++t) {
        const int32_t *c = mesh->tetrahedron[t];
        const double *p[4];
        double centroid[3] = {0.0}, corner[4][3], u[3], v[3], w[3], n[3];
        int others[2], found = 0, is_at = 0;
        for (int k = 0; k < 4; ++k) {
            p[k] = mesh->position[c[k]];
            ss_madd3(centroid, centroid, 0.25, p[k]);
            is_at += c[k] == 0 || c[k] == 1;
            if (c[k] != 0 && c[k] != 1 && found < 2) {
                others[found++] = k;
            }
        }
        ss_sub3(u, p[1], p[0]);
        ss_sub3(v, p[2], p[0]);
        ss_sub3(w, p[3], p[0]);
        ss_cross3(n, u, v);
        star += ss_dot3(n, w) / 6.0;
        if (is_at < 2) {
            continue;
        }
        const double *a = mesh->position[0], *b = mesh->position[1];
        for (int k = 0; k < 3; ++k) {
            corner[0][k] = 0.5 * (a[k] + b[k]);
            corner[1][k] = (a[k] + b[k] + p[others[0]][k]) / 3.0;
            corner[2][k] = centroid[k];
            corner[3][k] = (a[k] + b[k] + p[others[1]][k]) / 3.0;
        }
        for (int half = 1; half < 3; ++half) {
            ss_sub3(u, corner[half], corner[0]);
            ss_sub3(v, corner[half + 1], corner[0]);
            ss_cross3(n, u, v);
            dual += 0.5 * ss_norm3(n);
        }
    }
    for (int32_t k = 1; k < 13; ++k) {
        const int32_t e = edge_between(network, 0, k);
        assert_near(network->edge_weight[e], dual / h, 1e-12);
        assert_near(network->edge_rho[e], dual / h, 1e-12); /* q goes through the dual face */
    }
    assert_near(network->size[0], star / 4.0, 1e-12);
    assert_true(!network->is_source[0] && network->is_source[1]); /* sources on the surface */
    assert_true(network->surface_area[0] == 0.0 && network->surface_area[1] > 0.0);
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
}

TEST(what_is_left_of_an_edge_is_the_sum_of_its_elements)
{
    for (int kind = 0; kind < 3; ++kind) {
        ss_mesh *mesh = kind == 0   ? make_plate(4, 1.0)
                        : kind == 1 ? make_grid_cylinder(4, 6, 1.0, 2.0)
                                    : make_block(2, 1.0);
        ss_cnn_fabric fabric = {.mesh = mesh, .element = (ss_cnn_element)kind};
        ss_cnn_network *whole = network_of(&fabric, NULL);
        /* Without its last element the mesh has the templates of the whole less one share. */
        ss_cnn_share gone;
        ss_cnn_element_share(&fabric, ss_cnn_element_count(&fabric) - 1, &gone);
        mesh->triangle_count -= kind == 0;
        mesh->quad_count -= kind == 1;
        mesh->tetrahedron_count -= kind == 2;
        ss_cnn_network *rest = network_of(&fabric, NULL);
        for (int32_t e = 0; e < rest->edges.count; ++e) {
            const int32_t i = rest->edges.from[e] / 4, j = rest->edges.to[e] / 4;
            double lost = 0.0;
            for (int s = 0; s < gone.sides; ++s) {
                const int32_t a = gone.node[gone.side[s][0]], b = gone.node[gone.side[s][1]];
                lost += (a == i && b == j) || (a == j && b == i) ? gone.weight[s] : 0.0;
            }
            assert_near(rest->edge_weight[e], whole->edge_weight[edge_between(whole, i, j)] - lost,
                        1e-12);
        }
        for (int c = 0; c < gone.corners; ++c) {
            assert_near(rest->size[gone.node[c]], whole->size[gone.node[c]] - gone.size[c], 1e-12);
        }
        ss_cnn_network_destroy(&whole);
        ss_cnn_network_destroy(&rest);
        free_mesh(mesh);
    }
}

/* ---- patch tests ---- */

static void assert_moments(const ss_cnn_network *network, const ss_mesh *mesh, int32_t cell,
                           double xx, double yy, double zz)
{
    double d[3][3];
    assert_near(moments_of(network, mesh, cell, d), 0.0, 1e-12);
    const double expected[3] = {xx, yy, zz};
    for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
            assert_near(d[a][b], a == b ? expected[a] : 0.0, 1e-12);
        }
    }
}

TEST(a_linear_potential_is_reproduced_on_tensor_grids)
{
    static const double x[5] = {0.0, 0.3, 0.35, 1.0, 1.2}, even[5] = {0.0, 0.5, 1.0, 1.5, 2.0};
    ss_mesh *mesh = make_tensor_grid(5, 5, x, even);
    ss_cnn_network *network =
        network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_QUAD}, NULL);
    double d[3][3];
    for (int32_t n = 0; n < 25; ++n) {
        if (n / 5 % 4 != 0 && n % 5 % 4 != 0) {
            assert_moments(network, mesh, n, 1.0, 1.0, 0.0);
        }
    }
    assert_true(moments_of(network, mesh, 2, d) > 0.1); /* the border is open */
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
}

TEST(triangles_are_consistent_when_equilateral)
{
    ss_mesh *mesh = make_fan(0.3);
    ss_cnn_network *network =
        network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_TRIANGLE}, NULL);
    assert_moments(network, mesh, 0, 1.0, 1.0, 0.0);
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
    /* Squares cut by diagonals one way: still linear, but the Laplacian is 8 % high. */
    draft s;
    double d[3][3];
    draft_init(&s, 9, 8);
    for (int n = 0; n < 9; ++n) {
        draft_node(&s, n / 3, n % 3, 0.0);
    }
    for (int q = 0; q < 4; ++q) {
        const int32_t a = q / 2 * 3 + q % 2;
        draft_triangle(&s, a, a + 3, a + 4);
        draft_triangle(&s, a, a + 4, a + 1);
    }
    mesh = draft_finish(&s);
    network = network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_TRIANGLE}, NULL);
    assert_near(moments_of(network, mesh, 4, d), 0.0, 1e-12);
    assert_near(0.5 * (d[0][0] + d[1][1]), 1.08, 0.005);
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
}

/* A cell of the body-centred lattice: the centre (node 0), eight corners and six next centres. */
static ss_mesh *make_lattice_cell(void)
{
    double position[15][3] = {{0.0}};
    int32_t tetrahedron[24][4], count = 0;
    for (int n = 0; n < 8; ++n) {
        ss_set3(position[1 + n], n & 4 ? 0.5 : -0.5, n & 2 ? 0.5 : -0.5, n & 1 ? 0.5 : -0.5);
    }
    for (int f = 0; f < 6; ++f) {
        position[9 + f][f / 2] = f % 2 == 0 ? 1.0 : -1.0;
        for (int a = 0; a < 8; ++a) {
            for (int b = a + 1; b < 8; ++b) { /* edges of the cube on this face */
                const int bit = 4 >> f / 2, apart = a ^ b;
                const bool is_on = ((a & bit) != 0) == (f % 2 == 0) && (apart & bit) == 0 &&
                                   (apart & (apart - 1)) == 0;
                if (is_on) {
                    const int32_t nodes[4] = {0, 9 + f, 1 + a, 1 + b};
                    memcpy(tetrahedron[count++], nodes, sizeof nodes);
                }
            }
        }
    }
    return make_tetrahedra(15, (const double(*)[3])position, count,
                           (const int32_t(*)[4])tetrahedron);
}

TEST(tetrahedra_conduct_a_little_too_well)
{
    /* sum |D| L >= 6 V, equal only where every dual face stands upright on its edge. Linear and
     * isotropic in the body-centred lattice, 4 % high; linear, but stretched and 19 % high, in
     * cubes of six. */
    double d[3][3];
    ss_mesh *mesh = make_lattice_cell();
    assert_int_equal(mesh->tetrahedron_count, 24);
    ss_cnn_network *network =
        network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_TETRAHEDRON}, NULL);
    const double high = (2.0 + 3.0 * sqrt(2.0)) / 6.0;
    assert_near(network->size[0], 0.5, 1e-12);
    assert_moments(network, mesh, 0, high, high, high);
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
    mesh = make_block(2, 1.0);
    network = network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_TETRAHEDRON}, NULL);
    assert_near(moments_of(network, mesh, 13, d), 0.0, 1e-12);
    assert_near((d[0][0] + d[1][1] + d[2][2]) / 3.0, 1.189, 0.001);
    assert_near(d[0][1], d[1][2], 1e-12); /* stretched along the cubes' diagonal */
    assert_true(d[0][1] > 0.05);
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
}

/* ---- materials with a direction ---- */

TEST(a_grid_conducts_by_its_sides)
{
    enum { ROWS = 3, COLUMNS = 4, NODES = ROWS * COLUMNS };
    static const double x[ROWS] = {0.0, 0.3, 0.7}, y[COLUMNS] = {0.0, 0.2, 0.5, 1.0};
    static const double given[3][3] = {{0.2, 0.9, 0.0}, {-0.8, 0.1, 5.0}, {0.0, 0.0, 1.0}};
    double along[NODES], across[NODES];
    ss_mesh *mesh = make_tensor_grid(ROWS, COLUMNS, x, y);
    random_state = 9;
    for (int n = 0; n < NODES; ++n) {
        along[n] = 1.0 + 0.5 * random_unit();
        across[n] = 3.0 + random_unit();
    }
    ss_cnn_network *plain =
        network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_QUAD}, NULL);
    for (int k = -1; k < 3; ++k) { /* the grid's own u; near w; near u; upright: u */
        ss_cnn_network *network = network_of(&(ss_cnn_fabric){.mesh = mesh,
                                                              .element = SS_CNN_QUAD,
                                                              .rho = along,
                                                              .rho_across = across,
                                                              .direction = k < 0 ? NULL : given[k]},
                                             NULL);
        double largest = 0.0;
        for (int32_t e = 0; e < network->edges.count; ++e) {
            const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
            const bool is_along = (j - i == COLUMNS) == (k != 0);
            const double base = harmonic(along[i], along[j]);
            const double rho = is_along ? base : harmonic(across[i], across[j]);
            assert_near(network->edge_rho[e], rho, 1e-12);
            assert_near(network->edge_weight[e], plain->edge_weight[e] * rho / base, 1e-12);
            largest = fmax(largest, network->edge_rho[e]);
        }
        assert_true(network->largest_rho == largest);
        ss_cnn_network_destroy(&network);
    }
    ss_cnn_network_destroy(&plain);
    free_mesh(mesh);
}

/* Conducting by `along` and `across` a direction: of all elements, or of each its own. */
static ss_cnn_network *directed_network(const ss_mesh *mesh, ss_cnn_element element,
                                        const double *along, const double *across,
                                        const double *direction, const double (*per_element)[3])
{
    return network_of(&(ss_cnn_fabric){.mesh = mesh,
                                       .element = element,
                                       .rho = along,
                                       .rho_across = across,
                                       .direction = direction,
                                       .per_element = per_element},
                      NULL);
}

TEST(where_directions_differ_an_edge_takes_their_share)
{
    /* Two quads, one beside the other, the first with u along x, the second along y. */
    static const double x[2] = {0.0, 1.0}, y[3] = {0.0, 1.0, 4.0};
    static const double direction[2][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
    double along[6] = {1, 1, 1, 1, 1, 1}, across[6] = {5, 5, 5, 5, 5, 5};
    ss_mesh *mesh = make_tensor_grid(2, 3, x, y);
    ss_cnn_network *network = directed_network(mesh, SS_CNN_QUAD, along, across, NULL, direction);
    const int32_t shared = edge_between(network, 1, 4); /* w = 1/2 and 3/2 */
    assert_near(network->edge_weight[shared], 0.5 * 1.0 + 1.5 * 5.0, 1e-12);
    assert_near(network->edge_rho[shared], (0.5 * 1.0 + 1.5 * 5.0) / 2.0, 1e-12);
    assert_near(network->edge_rho[edge_between(network, 0, 1)], 5.0, 1e-12);
    assert_near(network->edge_rho[edge_between(network, 1, 2)], 1.0, 1e-12);
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
}

TEST(triangles_conduct_by_the_angle_to_the_projected_direction)
{
    /* Edges of three directions carry both: a ratio r comes out as (3 + r) : (1 + 3 r). */
    const double r = 4.0;
    double along[7], across[7], d[3][3];
    for (int k = 0; k < 7; ++k) {
        along[k] = 0.05;
        across[k] = r * 0.05;
    }
    ss_mesh *mesh = make_fan(0.3);
    for (int k = 0; k < 5; ++k) {
        const double angle = 0.3 + k, tilt = k == 4 ? 0.0 : 0.2 + 0.2 * k;
        const double direction[3] = {tilt * cos(angle), tilt * sin(angle), sqrt(1.0 - tilt * tilt)};
        ss_cnn_network *network =
            directed_network(mesh, SS_CNN_TRIANGLE, along, across, direction, NULL);
        /* Upright (the last) no direction in the plane is special. */
        const double low = k == 4 ? 0.5 * (1.0 + r) : 0.25 * (3.0 + r);
        const double high = k == 4 ? 0.5 * (1.0 + r) : 0.25 * (1.0 + 3.0 * r);
        const double c = cos(angle), s = sin(angle);
        assert_near(moments_of(network, mesh, 0, d), 0.0, 1e-12);
        assert_near(d[0][0], low * c * c + high * s * s, 1e-9);
        assert_near(d[1][1], low * s * s + high * c * c, 1e-9);
        assert_near(d[0][1], (low - high) * c * s, 1e-9);
        const int32_t e = edge_between(network, 0, 1); /* along x */
        const double a = k == 4 ? 0.5 * (1.0 + r) : c * c + r * s * s;
        assert_near(network->edge_weight[e], a / sqrt(3.0), 1e-9);
        assert_near(network->edge_rho[e], 0.05 * a, 1e-9);
        ss_cnn_network_destroy(&network);
    }
    free_mesh(mesh);
}

TEST(tetrahedra_conduct_by_the_angle_in_space)
{
    static const double direction[3] = {0.48, -0.6, 0.64};
    double along[27], across[27];
    ss_mesh *mesh = make_block(2, 1.0);
    for (int k = 0; k < 27; ++k) {
        along[k] = 2.0;
        across[k] = 0.5;
    }
    ss_cnn_network *plain =
        network_of(&(ss_cnn_fabric){.mesh = mesh, .element = SS_CNN_TETRAHEDRON}, NULL);
    ss_cnn_network *network =
        directed_network(mesh, SS_CNN_TETRAHEDRON, along, across, direction, NULL);
    for (int32_t e = 0; e < network->edges.count; ++e) {
        double arm[3];
        ss_sub3(arm, mesh->position[network->edges.to[e] / 4],
                mesh->position[network->edges.from[e] / 4]);
        ss_normalize3(arm);
        const double cosine = ss_dot3(arm, direction);
        const double a = cosine * cosine + 0.25 * (1.0 - cosine * cosine);
        assert_near(network->edge_weight[e], a * plain->edge_weight[e], 1e-12);
        assert_near(network->edge_rho[e], 2.0 * network->edge_weight[e], 1e-12);
    }
    ss_cnn_network_destroy(&plain);
    ss_cnn_network_destroy(&network);
    free_mesh(mesh);
}

/* ---- columns against a dense solve ---- */

/* Solves A x = b in place by elimination with pivots; x in b. */
static void solve_dense(int n, double *a, double *b)
{
    for (int k = 0; k < n; ++k) {
        int pivot = k;
        for (int i = k + 1; i < n; ++i) {
            pivot = fabs(a[i * n + k]) > fabs(a[pivot * n + k]) ? i : pivot;
        }
        for (int j = 0; j < n; ++j) {
            const double t = a[k * n + j];
            a[k * n + j] = a[pivot * n + j];
            a[pivot * n + j] = t;
        }
        const double t = b[k];
        b[k] = b[pivot];
        b[pivot] = t;
        for (int i = 0; i < n; ++i) {
            const double factor = i == k ? 0.0 : a[i * n + k] / a[k * n + k];
            for (int j = k; j < n; ++j) {
                a[i * n + j] -= factor * a[k * n + j];
            }
            b[i] -= factor * b[k];
        }
    }
    for (int k = 0; k < n; ++k) {
        b[k] /= a[k * n + k];
    }
}

/* kap of one cell from the equations of a whole matrix that must be symmetric. */
static void check_column(const ss_cnn_network *network, ss_cnn_network *solved, const uint8_t *held,
                         const double *rho, bool is_volume, int32_t cell)
{
    const int n = network->node_count;
    const double one = 1.0;
    double *a = calloc((size_t)(n * n), sizeof *a), *x = calloc((size_t)n, sizeof *x);
    double *kap = calloc((size_t)network->edges.padded_count, sizeof *kap);
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
        const double c = network->edge_weight[e];
        assert_true(c > 0.0);
        a[i * n + j] -= c;
        a[j * n + i] -= c;
        a[i * n + i] += c;
        a[j * n + j] += c;
    }
    for (int32_t i = 0; i < n; ++i) {
        for (int32_t j = 0; held[i] && j < n; ++j) {
            a[i * n + j] = i == j ? 1.0 : 0.0;
        }
    }
    x[cell] = network->size[cell] / rho[cell];
    solve_dense(n, a, x);
    assert_int_equal(ss_cnn_network_superpose(solved, 1, &cell, &one, kap), SOFTSIM_OK);
    double qhat = 0.0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int32_t e = 0; e < network->edges.count; ++e) {
            const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
            /* On surfaces edge_rho is rho itself, in volumes the dual face counts too. */
            const double q = network->edge_rho[e] * fabs(x[i] - x[j]) / network->edge_square[e];
            if (pass == 0) {
                qhat += q * network->edge_square[e];
            } else {
                assert_near(kap[e], q / qhat, 1e-9 / network->edge_square[e]);
            }
        }
    }
    assert_near(solved->qhat[cell], qhat, 1e-9 * qhat);
    assert_near(solved->own[cell], x[cell], 1e-9 * x[cell]);
    /* What the dual faces at the cell carry is what it was given. */
    double carried = 0.0;
    for (int32_t e = 0; e < network->edges.count; ++e) {
        const int32_t i = network->edges.from[e] / 4, j = network->edges.to[e] / 4;
        carried += i == cell || j == cell ? network->edge_rho[e] * fabs(x[i] - x[j]) : 0.0;
    }
    if (is_volume) {
        assert_near(carried, network->size[cell], 1e-9 * carried);
    }
    free(a);
    free(x);
    free(kap);
}

TEST(columns_agree_with_a_dense_solve)
{
    static const double direction[3] = {0.6, 0.0, 0.8};
    for (int run = 0; run < 6; ++run) {
        const int kind = run % 3; /* the second time without a factor */
        ss_mesh *mesh = kind == 0   ? make_cylinder(6, 8, 1.0, 3.0)
                        : kind == 1 ? make_grid_cylinder(6, 8, 1.0, 3.0)
                                    : make_block(3, 1.0);
        const int n = mesh->node_count;
        double along[64], across[64];
        uint8_t held[64] = {0};
        random_state = 31;
        for (int i = 0; i < n; ++i) {
            held[i] = mesh->position[i][2] < -0.49;
            /* In volumes it is equal along, so that what a cell sends out can be told. */
            along[i] = kind == 2 ? 1.0 : 1.0 + 0.8 * random_unit();
            across[i] = 3.0 + 2.0 * random_unit();
        }
        const ss_cnn_fabric fabric = {.mesh = mesh,
                                      .element = (ss_cnn_element)kind,
                                      .rho = along,
                                      .rho_across = across,
                                      .direction = direction,
                                      .max_work = run < 3 ? 0.0 : 1.0};
        ss_cnn_network *network = network_of(&fabric, held);
        assert_int_equal(network->factor->is_given_up, run >= 3);
        for (int32_t cell = 0; cell < n; cell += 5) {
            if (!held[cell]) {
                check_column(network, network, held, along, kind == 2, cell);
            }
        }
        ss_cnn_network_destroy(&network);
        free_mesh(mesh);
    }
}

/* Nothing is held: every part drains and has a cell pinned. */
TEST(a_drained_network_settles_the_same_without_a_factor)
{
    static const int32_t node[3] = {3, 17, 40};
    static const double weight[3] = {0.5, 0.3, 0.2};
    ss_mesh *mesh = make_cylinder(6, 8, 1.0, 3.0);
    ss_cnn_fabric fabric = {.mesh = mesh, .element = SS_CNN_TRIANGLE};
    double *kap[2], largest = 0.0;
    for (int run = 0; run < 2; ++run) {
        fabric.max_work = run == 0 ? 0.0 : 1.0;
        ss_cnn_network *network = network_of(&fabric, NULL);
        kap[run] = calloc((size_t)network->edges.padded_count, sizeof **kap);
        assert_non_null(kap[run]);
        assert_int_equal(ss_cnn_network_superpose(network, 3, node, weight, kap[run]), SOFTSIM_OK);
        for (int32_t e = 0; e < network->edges.count; ++e) {
            largest = fmax(largest, kap[0][e]);
            assert_true(fabs(kap[run][e] - kap[0][e]) <= 1e-9 * largest);
        }
        ss_cnn_network_destroy(&network);
    }
    assert_true(largest > 0.0);
    free(kap[0]);
    free(kap[1]);
    free_mesh(mesh);
}

int main(void)
{
    ss_thread_flush_denormals();
    return run_all_tests(NULL, NULL);
}
