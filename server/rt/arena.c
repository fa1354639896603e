/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * A piece is [64 bytes: the piece before it][the caller's bytes], an allocation of its own.
 * Rejected: pieces side by side in large blocks, where an overrun of one byte meets another array
 * instead of AddressSanitizer.
 */
#include "rt/arena.h"

#include <stdint.h>
#include <string.h>

#include "rt/memory.h"

enum { ALIGNMENT = 64 };

struct ss_arena_piece {
    _Alignas(ALIGNMENT) ss_arena_piece *before;
};

void *ss_arena_get(ss_arena *arena, size_t count, size_t size)
{
    const bool is_too_large = size != 0 && count > ((size_t)PTRDIFF_MAX - ALIGNMENT) / size;
    ss_arena_piece *piece =
        is_too_large ? NULL : ss_memory_get(sizeof *piece + count * size, sizeof(char));
    if (piece == NULL) {
        arena->is_short = true;
        return NULL;
    }
    piece->before = arena->last;
    arena->last = piece;
    return piece + 1;
}

void ss_arena_take(ss_arena *arena, const ss_arena_room *room, size_t rooms)
{
    for (size_t i = 0; i < rooms; ++i) {
        void *memory = ss_arena_get(arena, room[i].count, room[i].size);
        memcpy(room[i].pointer, &memory, sizeof memory);
    }
}

softsim_status ss_arena_status(const ss_arena *arena)
{
    return arena->is_short ? SOFTSIM_ERROR_MEMORY : SOFTSIM_OK;
}

void ss_arena_free(ss_arena *arena)
{
    while (arena->last != NULL) {
        ss_arena_piece *gone = arena->last;
        arena->last = gone->before;
        ss_memory_free(gone);
    }
    arena->is_short = false;
}
