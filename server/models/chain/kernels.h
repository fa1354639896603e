/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * The inner loops of cnn-chainmail, built for more than one processor and chosen at start.
 *
 * Node arrays: 4 ss_real a node, one node more than the mesh has (the one that lanes without a link
 * name) and padded to an even number. Thread: any; RT-safe.
 */
#include "models/chain/net.h"

/* A set of numbers from 0 that is gone through in increasing order: a bit each, and a bit for each
 * word of them that is not 0. */
typedef struct ss_chain_set {
    uint64_t *bit, *word;
    int32_t word_count, top_count;
} ss_chain_set;

static inline void ss_chain_set_add(ss_chain_set *set, int32_t number)
{
    set->bit[number >> 6] |= (uint64_t)1 << (number & 63);
    set->word[number >> 12] |= (uint64_t)1 << ((number >> 6) & 63);
}

/* The lowest number from `from` on; -1 when there is none. */
static inline int32_t ss_chain_set_next(const ss_chain_set *set, int32_t from)
{
    int32_t at = from >> 6;
    uint64_t bits = at < set->word_count ? set->bit[at] >> (from & 63) << (from & 63) : 0;
    if (bits == 0) {
        ++at;
        int32_t top = at >> 6;
        uint64_t words = top < set->top_count ? set->word[top] >> (at & 63) << (at & 63) : 0;
        while (words == 0 && ++top < set->top_count) {
            words = set->word[top];
        }
        if (words == 0) {
            return -1;
        }
        at = 64 * top + __builtin_ctzll(words);
        bits = set->bit[at];
    }
    return 64 * at + __builtin_ctzll(bits);
}

/* Where something happens: the wavefront. A group sleeps while all its links are slack and no node
 * of it has moved since it was last looked at; leaving it out changes nothing. */
typedef struct ss_chain_front {
    ss_chain_set awake, next;  /* groups to look at now, and in the next sub-step */
    ss_chain_set moving, stay; /* nodes to move now, and in the next sub-step whatever pulls */
    int64_t groups, nodes;     /* looked at, moved, so far */
} ss_chain_front;

typedef struct ss_chain_motion {
    ss_real h;               /* s */
    const ss_real *mobility; /* 1/C on every axis that may move, 1/s, 4 a node */
    ss_real leak;            /* 1/R_rest */
    ss_real *pull;           /* in: what moves the nodes, m; out: 0 */
    ss_real *u;              /* moved */
    double largest;          /* out: of |u|'s components, m; NaN when one is not finite */
} ss_chain_motion;

/* Phi of coarse.c: blocks of nodes near one another, in each of which the weight of a cell is
 * linear in a node's place: w = c0 + c1 x + c2 y + c3 z. */
enum { SS_CHAIN_MAX_BLOCK = 48 };
typedef struct ss_chain_hats {
    int32_t block_count, cell_count;
    int32_t block;        /* nodes of one, even */
    int32_t nobody;       /* the node too many, times 4 */
    int32_t *node;        /* `block` of each, times 4; the one too many fills the last */
    int32_t *taking_part; /* the same, but the one too many for those that do not take part */
    ss_real *place;       /* x y z of each, about the block's middle */
    int32_t *first;       /* of a block's entries, block_count + 1 */
    int32_t *cell;        /* of an entry, times 4 */
    ss_real *linear;      /* c0 to c3 of an entry */
} ss_chain_hats;

/* Tetrahedra for guard.c. */
typedef struct ss_chain_tet_group {
    int32_t corner[4][SS_CHAIN_LANES]; /* nodes times 4 */
    ss_real limit[SS_CHAIN_LANES];     /* m^3: of six volumes */
} ss_chain_tet_group;

typedef struct ss_chain_tets {
    int32_t group_count;
    ss_chain_tet_group *group;
} ss_chain_tets;

typedef struct ss_chain_kernels {
    const char *name;
    /* Adds dP = sum w/2 ex n of all groups to `pull`; `ratio` scales alpha. Returns
     * W = sum w/4 ex^2, m^2. */
    double (*pull)(const ss_chain_net *net, ss_real ratio, const ss_real *u, ss_real *pull);
    /* W alone. */
    double (*measure)(const ss_chain_net *net, ss_real ratio, const ss_real *u);
    /* pull() for the groups that are awake: those with a link out of its band stay awake, and
     * their nodes move. */
    double (*pull_front)(const ss_chain_net *net, ss_real ratio, const ss_real *u, ss_real *pull,
                         ss_chain_front *front);
    /* u += h mobility (pull - leak u), of `count` nodes. */
    void (*move)(int32_t count, ss_chain_motion *motion);
    /* The same for the nodes of the front; those that move wake their groups. */
    void (*move_front)(const ss_chain_net *net, ss_chain_front *front, ss_chain_motion *motion);
    /* out_cell (a quad each) = Phi' pull, of the elements that take part */
    void (*gather)(const ss_chain_hats *hats, const ss_real *pull, ss_real *out_cell);
    /* out = matrix cell, of count x count scalars and count quads; count a multiple of 4 */
    void (*apply)(int32_t count, const ss_real *matrix, const ss_real *cell, ss_real *out);
    /* u += scale mask Phi cell */
    void (*spread)(const ss_chain_hats *hats, const ss_real *mask, const ss_real *cell,
                   ss_real scale, ss_real *u);
    /* Lists the tetrahedra whose six volumes are below their limit; returns their number. */
    int32_t (*collapse)(const ss_chain_tets *tets, const ss_real *place, int32_t *out_list);
} ss_chain_kernels;

/* The best of the paths that were built; RT-safe. */
const ss_chain_kernels *ss_chain_kernels_get(void);
/* Path `index`, best first, or NULL: for tests that compare them. */
const ss_chain_kernels *ss_chain_kernels_path(int32_t index);
