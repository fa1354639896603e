/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#include "mesh/msh_parts.h"

#include <stdio.h>

static const struct {
    ss_mesh_kind kind;
    const char *name;
} types[] = {
    {SS_MESH_OTHER, "unknown"},
    {SS_MESH_LINE, "line"},
    {SS_MESH_TRIANGLE, "triangle"},
    {SS_MESH_QUAD, "quadrangle"},
    {SS_MESH_TETRAHEDRON, "tetrahedron"},
    {SS_MESH_HEXAHEDRON, "hexahedron"},
    {SS_MESH_PRISM, "prism"},
    {SS_MESH_PYRAMID, "pyramid"},
    {SS_MESH_LINE_2, "second-order line"},
    {SS_MESH_TRIANGLE_2, "second-order triangle"},
    {SS_MESH_HIGHER_ORDER, "second-order quadrangle"},
    {SS_MESH_TETRAHEDRON_2, "second-order tetrahedron"},
    {SS_MESH_HIGHER_ORDER, "second-order hexahedron"},
    {SS_MESH_HIGHER_ORDER, "second-order prism"},
    {SS_MESH_HIGHER_ORDER, "second-order pyramid"},
    {SS_MESH_POINT, "point"},
    {SS_MESH_HIGHER_ORDER, "second-order quadrangle"},
    {SS_MESH_HIGHER_ORDER, "second-order hexahedron"},
    {SS_MESH_HIGHER_ORDER, "second-order prism"},
    {SS_MESH_HIGHER_ORDER, "second-order pyramid"},
};
enum { TYPE_COUNT = sizeof types / sizeof types[0], TYPE_LAST = 140 /* that Gmsh numbers */ };

ss_mesh_kind ss_msh_kind(int64_t type)
{
    return type > 0 && type < TYPE_COUNT            ? types[type].kind
           : type >= TYPE_COUNT && type < TYPE_LAST ? SS_MESH_HIGHER_ORDER
                                                    : SS_MESH_OTHER;
}

const char *ss_msh_type_name(int64_t type)
{
    return type > 0 && type < TYPE_COUNT ? types[type].name : "no triangle or tetrahedron";
}

int32_t ss_msh_find_node(const ss_msh *r, int64_t index, int64_t number)
{
    const int32_t node = ss_draft_find_node(r->draft, number);
    if (node < 0) {
        ss_text_fault(r->text,
                      "element %lld: there is no node number %lld: correct it or add the node",
                      (long long)index, (long long)number);
    }
    return node;
}

void ss_msh_note_other(ss_msh *r, int64_t index, int64_t type)
{
    const ss_mesh_kind kind = ss_msh_kind(type);
    const bool is_other = !ss_draft_makes_mesh(kind) && kind > SS_MESH_LINE_2;
    if (is_other && r->other[0] == '\0') {
        (void)snprintf(r->other, sizeof r->other, "element %lld (line %d) is of type %lld (%s)",
                       (long long)index, r->text->line, (long long)type, ss_msh_type_name(type));
    }
}

int32_t ss_msh_dimension(ss_mesh_kind kind)
{
    return ss_draft_is_volume(kind)                         ? 3
           : kind == SS_MESH_POINT                          ? 0
           : kind == SS_MESH_LINE || kind == SS_MESH_LINE_2 ? 1
                                                            : 2;
}

int32_t ss_msh_find_group(ss_msh *r, int32_t dimension, int64_t number)
{
    return ss_draft_find_group(r->draft, ((int64_t)dimension << 32) + number, NULL);
}

bool ss_msh_expect_end(ss_msh *r, const char *end)
{
    ss_text_span line;
    if (!ss_text_next_line(r->text, &line)) {
        ss_text_fault(r->text,
                      "the text ends before %s: the file is cut off, copy or write it again", end);
        return false;
    }
    if (!ss_span_is(line, end)) {
        ss_text_fault(r->text,
                      "%s expected here: the count at the start of the section does not fit it",
                      end);
        return false;
    }
    return true;
}

bool ss_msh_has_room(ss_msh *r, int64_t count, int64_t least, const char *what)
{
    /* The last line may lack its end. */
    if (count > SS_DRAFT_MAX_COUNT || count > ss_text_left(r->text) / least + 1) {
        ss_text_fault(r->text, "%lld %s announced, but %s: the file is damaged or cut off",
                      (long long)count, what,
                      count > SS_DRAFT_MAX_COUNT ? "more than 67 million are not read"
                                                 : "the rest of the file is too short for them");
        return false;
    }
    return true;
}

bool ss_msh_begin_elements(ss_msh *r, ss_text_mark start)
{
    const bool is_good = ss_draft_make_elements(r->draft, r->other[0] != '\0' ? r->other : NULL);
    if (is_good) {
        ss_text_seek(r->text, start);
    }
    return is_good;
}
