/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Three buffers: the writer's draft, the reader's front, and the one between them. `middle` holds
 * the number of the one between and whether it is fresh. Posting exchanges draft and middle,
 * taking exchanges front and middle; each buffer has exactly one owner at any time.
 *
 *   writer:  fill draft;  old = exchange(middle, draft | FRESH);  draft = old & INDEX
 *   reader:  if middle is FRESH:  old = exchange(middle, front);  front = old & INDEX
 */
#include "rt/mailbox.h"

#include <stdalign.h>
#include <stdatomic.h>

#include "rt/each.h"
#include "rt/memory.h"

enum { LINE = 64, INDEX = 3, FRESH = 4 };

struct ss_mailbox {
    char *values;
    size_t stride;
    /* Each side's word has a cache line of its own. */
    alignas(LINE) atomic_uint middle;
    alignas(LINE) unsigned draft; /* writer's */
    alignas(LINE) unsigned front; /* reader's */
    bool has_front;               /* reader's: something was taken */
};

ss_mailbox *ss_mailbox_create(size_t value_size)
{
    if (value_size > SIZE_MAX / 2) {
        return NULL;
    }
    ss_mailbox *mailbox = ss_memory_get(1, sizeof *mailbox);
    if (mailbox == NULL) {
        return NULL;
    }
    mailbox->stride = (value_size + LINE - 1) / LINE * LINE;
    mailbox->values = ss_memory_get(3, mailbox->stride);
    if (mailbox->values == NULL) {
        ss_memory_free(mailbox);
        return NULL;
    }
    mailbox->draft = 0;
    mailbox->front = 1;
    atomic_init(&mailbox->middle, 2u);
    return mailbox;
}

void ss_mailbox_destroy(ss_mailbox **mailbox)
{
    if (*mailbox != NULL) {
        SS_EACH(ss_memory_free, (*mailbox)->values, *mailbox);
        *mailbox = NULL;
    }
}

void *ss_mailbox_draft(ss_mailbox *mailbox)
{
    return mailbox->values + mailbox->draft * mailbox->stride;
}

void ss_mailbox_post(ss_mailbox *mailbox)
{
    /* Release: the draft's content is visible to whoever takes it (pairs with the acquire in
     * take). Acquire: the reader is done with the buffer that it gave back (pairs with the release
     * in take). */
    const unsigned old =
        atomic_exchange_explicit(&mailbox->middle, mailbox->draft | FRESH, memory_order_acq_rel);
    mailbox->draft = old & INDEX;
}

const void *ss_mailbox_take(ss_mailbox *mailbox, bool *out_is_new)
{
    /* Relaxed: only a hint; the exchange below orders. Only this thread clears FRESH, so that a
     * fresh middle stays fresh until then. */
    const bool is_new = (atomic_load_explicit(&mailbox->middle, memory_order_relaxed) & FRESH) != 0;
    if (is_new) {
        /* Acquire: sees what was posted (pairs with the release in post). Release: our reads of
         * the old front are over (pairs with the acquire in post). */
        const unsigned old =
            atomic_exchange_explicit(&mailbox->middle, mailbox->front, memory_order_acq_rel);
        mailbox->front = old & INDEX;
        mailbox->has_front = true;
    }
    if (out_is_new != NULL) {
        *out_is_new = is_new;
    }
    return mailbox->has_front ? mailbox->values + mailbox->front * mailbox->stride : NULL;
}
