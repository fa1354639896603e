/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/* A server that stands: which of its forces are of no body. */
#include "common/test.h"

#include <stdlib.h>
#include <string.h>

#include "halt.h"

static void take(ss_halt *halt, int32_t seq, int32_t flags, bool is_new)
{
    const softsim_force force = {.pose_seq = seq, .probe = 1, .flags = flags};
    ss_halt_take_force(halt, &force, is_new);
}

static void hear(ss_halt *halt, int32_t verdict, int32_t bits, const char *reason)
{
    const softsim_server_status status = {.verdict = verdict, .fault_bits = bits, .reason = reason};
    ss_halt_take_status(halt, &status);
}

static void expect_said(const ss_halt *halt, const char *said)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    ss_halt_print(halt, out, "p: ");
    fclose(out);
    assert_string_equal(text, said);
    free(text);
}

/* All that ramp in a row about the status that tells it, and none of another row. */
TEST(a_row_that_ramps_is_of_a_pause_that_a_status_tells)
{
    ss_halt halt = {0};
    take(&halt, 1, SOFTSIM_FORCE_RAMPING, true); /* it comes in */
    take(&halt, 2, 0, true);
    hear(&halt, SOFTSIM_VERDICT_GOOD, 0, "");
    take(&halt, 3, SOFTSIM_FORCE_RAMPING, true);
    take(&halt, 3, SOFTSIM_FORCE_RAMPING, false);
    assert_false(ss_halt_is_seen(&halt));
    hear(&halt, SOFTSIM_VERDICT_GUARDED, SOFTSIM_STATUS_PAUSED, "of another thing");
    take(&halt, 4, SOFTSIM_FORCE_RAMPING, true);
    take(&halt, 5, SOFTSIM_FORCE_CONTACT, true);
    expect_said(&halt, "p: the server is paused from pose 3 on; 3 forces are of it: "
                       "`softsim-monitor --command resume`\n");
}

/* Nor are a silence, another sender or a fault a pause, though the server is paused besides. */
TEST(what_ramps_for_another_reason_is_no_pause)
{
    ss_halt halt = {0};
    take(&halt, 1, SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_STALE, true);
    take(&halt, 2, SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_OTHER_SENDER, true);
    hear(&halt, SOFTSIM_VERDICT_GOOD, SOFTSIM_STATUS_PAUSED, "");
    take(&halt, 3, SOFTSIM_FORCE_CONTACT, true);
    assert_false(ss_halt_is_seen(&halt));
    expect_said(&halt, "");
}

/* The last pose was answered before. */
TEST(what_begins_after_the_last_pose_is_none)
{
    ss_halt halt = {0};
    take(&halt, 9, SOFTSIM_FORCE_CONTACT, true);
    take(&halt, 9, SOFTSIM_FORCE_RAMPING, false);
    hear(&halt, SOFTSIM_VERDICT_GOOD, SOFTSIM_STATUS_PAUSED, "");
    take(&halt, 9, SOFTSIM_FORCE_RAMPING, false);
    take(&halt, 9, SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_MODEL_FAULT, false);
    assert_false(ss_halt_is_seen(&halt));
}

TEST(a_status_tells_a_fault_from_a_late_model)
{
    static const int32_t flags = SOFTSIM_FORCE_RAMPING | SOFTSIM_FORCE_MODEL_FAULT;
    ss_halt halt = {0};
    hear(&halt, SOFTSIM_VERDICT_FAULT, 0, "of before");
    take(&halt, 7, flags, true);
    take(&halt, 7, flags, false);
    assert_false(ss_halt_is_clear(&halt));
    expect_said(&halt, "p: the server's model is at fault from pose 7 on; 2 forces are of it: "
                       "`softsim-monitor --command reset`\n");
    hear(&halt, SOFTSIM_VERDICT_GOOD, 0, ""); /* it may have been on its way */
    assert_false(ss_halt_is_clear(&halt));
    hear(&halt, SOFTSIM_VERDICT_GOOD, 0, "");
    assert_true(ss_halt_is_clear(&halt));
    assert_string_equal(ss_halt_name(&halt), "late");
    hear(&halt, SOFTSIM_VERDICT_FAULT, 0, "a number is \x1b[31mnot finite");
    expect_said(&halt, "p: the server's model is at fault from pose 7 on (a number is ?[31mnot "
                       "finite); 2 forces are of it: `softsim-monitor --command reset`\n");
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
