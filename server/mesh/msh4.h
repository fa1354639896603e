/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/* Sections of MSH 4.1. False with a fault in the text. */
#include "mesh/msh_parts.h"

bool ss_msh4_read_entities(ss_msh *r);
bool ss_msh4_read_nodes(ss_msh *r);
bool ss_msh4_read_elements(ss_msh *r);
