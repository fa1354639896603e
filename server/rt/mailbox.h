/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * Mailbox: the latest value from one writer thread to one reader thread, wait-free on both sides
 * (triple buffer). A value is written in place and posted; the reader takes the newest posted one
 * and owns it until its next take. Nothing is torn, nothing waits, older values are overwritten.
 * Alternative rejected: a seqlock, whose reader may retry without bound and is a data race in C11.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ss_mailbox ss_mailbox;

/* Thread: set-up only. `value_size` bytes a value, zeroed. NULL when out of memory. */
ss_mailbox *ss_mailbox_create(size_t value_size);
void ss_mailbox_destroy(ss_mailbox **mailbox);

/* Writer thread; RT-safe. The buffer to fill next (its content is stale); then post it. */
void *ss_mailbox_draft(ss_mailbox *mailbox);
void ss_mailbox_post(ss_mailbox *mailbox);

/* Reader thread; RT-safe. The newest posted value, NULL before the first post; *out_is_new (may
 * be NULL) tells whether it was posted since the last take. Valid until the next take. */
const void *ss_mailbox_take(ss_mailbox *mailbox, bool *out_is_new);
