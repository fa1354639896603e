/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Set-up memory of one owner: taken piece by piece, released all at once.
 *
 * An owner asks for all its arrays and looks once whether it has got them; what it takes needs no
 * list of its own to be freed by. {0} is an arena without a piece. Each piece is as ss_memory_get
 * gives it: zeroed, on 64 bytes, counted. Thread: as memory.h.
 */
#include <stdbool.h>
#include <stddef.h>

#include "softsim/types.h"

typedef struct ss_arena_piece ss_arena_piece;
typedef struct ss_arena {
    ss_arena_piece *last;
    bool is_short; /* a piece was refused */
} ss_arena;

/* NULL when out of memory or when count * size overflows; a zero count gives a valid pointer. */
void *ss_arena_get(ss_arena *arena, size_t count, size_t size);
/* Many at once, each told by its length: SS_ARENA_TAKE(arena, SS_ROOM(n, mass), SS_ROOM(m, edge)).
 */
#define SS_ARENA_TAKE(arena, ...)                                                                  \
    ss_arena_take((arena), (const ss_arena_room[]){__VA_ARGS__},                                   \
                  sizeof((const ss_arena_room[]){__VA_ARGS__}) / sizeof(ss_arena_room))
#define SS_ROOM(count, array)                                                                      \
    {                                                                                              \
        &(array), (count), sizeof *(array)                                                         \
    }
typedef struct ss_arena_room {
    void *pointer; /* to the array's */
    size_t count, size;
} ss_arena_room;
void ss_arena_take(ss_arena *arena, const ss_arena_room *room, size_t rooms);
/* SOFTSIM_ERROR_MEMORY once any piece was refused. */
softsim_status ss_arena_status(const ss_arena *arena);
/* Releases every piece; the arena is {0} again. */
void ss_arena_free(ss_arena *arena);
