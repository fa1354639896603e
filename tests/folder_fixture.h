/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* A folder of a test's own, made before its group runs and removed with all in it afterwards. The
 * test says its name first: static char folder[] = "/tmp/..._XXXXXX". */
#include <stdio.h>
#include <stdlib.h>

static inline int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) != NULL ? 0 : -1;
}

static inline int remove_folder(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}
