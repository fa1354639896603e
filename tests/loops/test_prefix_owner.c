/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "common/test.h"

#include <stdint.h>

#include "loops/prefix_owner.h"

/* The channel says which probe it is; what a pose names is the sender's affair. */
TEST(a_probe_out_of_range_is_nobodys)
{
    static const int32_t named[] = {-1, 8, 1000, INT32_MIN, INT32_MAX};
    struct {
        char before[256];
        ss_prefix_owner owner;
        char behind[256];
    } guarded = {.owner = {.start_us = 1}}, untouched = guarded;
    for (size_t i = 0; i < sizeof named / sizeof *named; ++i) {
        const softsim_pose pose = {.sender = 77, .probe = named[i]};
        ss_prefix_owner_note_pose(&guarded.owner, named[i], &pose, 5);
        assert_memory_equal(&guarded, &untouched, sizeof guarded);
    }
    const softsim_pose pose = {.sender = 77, .probe = INT32_MAX};
    ss_prefix_owner_note_pose(&guarded.owner, 3, &pose, 5);
    assert_int_equal(guarded.owner.hand[3].sender, 77);
}

int main(void)
{
    return run_all_tests(NULL, NULL);
}
