/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Reader of Gmsh MSH text, versions 1 and 2.0 to 2.2; the sections of 4.1 are in msh4.c.
 *
 *   $MeshFormat / 2.2 0 8 / $EndMeshFormat              (version 1 has none: $NOD, $ELM)
 *   $PhysicalNames / n / dimension number "name" ...
 *   $Nodes / n / tag x y z ...
 *   $Elements / n / tag type tag-count physical ... nodes   (1: tag type physical region n nodes)
 *
 * Nodes and elements are numbered from 0 in the order of the file; tags may be any positive
 * numbers with any gaps. What is kept: draft.c. Elements of other kinds are skipped and counted;
 * a file of nothing else is refused, naming the first.
 *
 * Nothing in the text is trusted: a count larger than the rest of the text could hold is refused
 * before anything is allocated, so memory stays within a small multiple of the file. The section
 * of elements is read twice, first for the kinds alone, so that each array gets its own size.
 */
#include "mesh/msh4.h"
#include "mesh/msh_parts.h"
#include "mesh/readers.h"
#include "mesh/second_order.h"
#include "rt/each.h"
#include "rt/memory.h"

#include <stdio.h>
#include <string.h>

enum { MIN_RECORD = 7 }; /* bytes of the shortest line of a node or element, "1 0 0 0" */

/* ---- sections ---- */

/* The file's names, or "surface-2" and the like. */
static void name_groups(ss_msh *r)
{
    static const char *const kinds[] = {"point", "line", "surface", "volume"};
    for (int32_t g = 0; g < r->draft->group_count; ++g) {
        ss_draft_group *group = &r->draft->group[g];
        const int32_t dimension = (int32_t)(group->key >> 32);
        const int32_t number = (int32_t)(group->key & INT32_MAX);
        (void)snprintf(group->name, sizeof group->name, "%s-%d", kinds[dimension], number);
        for (int32_t i = r->name_count - 1; i >= 0; --i) {
            if (r->name[i].dimension == dimension && r->name[i].number == number &&
                r->name[i].name[0] != '\0') {
                memcpy(group->name, r->name[i].name, sizeof group->name);
            }
        }
    }
}

/* The line with the number of records. */
static bool read_count(ss_msh *r, const char *what, int64_t *out)
{
    ss_text_span line;
    if (!ss_text_next_line(r->text, &line) || !ss_span_next_int64(&line, out) ||
        !ss_span_is_blank(line) || *out < 0) {
        ss_text_fault(r->text, "the number of %s expected here, alone on its line", what);
        return false;
    }
    return ss_msh_has_room(r, *out, MIN_RECORD, what);
}

static bool read_format(ss_msh *r)
{
    ss_text_span line;
    double version = 0.0;
    int64_t is_binary = 0;
    int64_t size = 0;
    if (!ss_text_next_line(r->text, &line) || !ss_span_next_number(&line, &version) ||
        !ss_span_next_int32(&line, &is_binary) || !ss_span_next_int32(&line, &size)) {
        ss_text_fault(r->text, "a line such as \"%s\" expected here", "2.2 0 8");
        return false;
    }
    const bool is_two = version >= 2.0 && version < 3.0;
    const bool is_four = version > 4.05 && version < 4.15;
    if (is_binary != 0 || (!is_two && !is_four)) {
        ss_text_fault(r->text,
                      "Gmsh format %g%s is not read: write the mesh as version 2.2 or 4.1 ASCII "
                      "(gmsh -save -format msh22 IN.msh -o OUT.msh)",
                      version, is_binary != 0 ? " binary" : "");
        return false;
    }
    r->version = is_two ? 2 : 4;
    return ss_msh_expect_end(r, "$EndMeshFormat");
}

static bool read_name(ss_msh *r, ss_msh_name *out)
{
    ss_text_span line;
    int64_t dimension = 0;
    int64_t number = 0;
    if (!ss_text_next_line(r->text, &line) || !ss_span_next_int32(&line, &dimension) ||
        !ss_span_next_int32(&line, &number) || dimension < 0 || dimension > 3) {
        ss_text_fault(r->text, "a line such as %s expected here", "2 1 \"name\"");
        return false;
    }
    const char *open = memchr(line.begin, '"', (size_t)(line.end - line.begin));
    const bool is_quoted = open != NULL && line.end - open >= 2 && line.end[-1] == '"';
    if (!is_quoted || !ss_span_copy((ss_text_span){.begin = open + 1, .end = line.end - 1},
                                    out->name, sizeof out->name)) {
        ss_text_fault(r->text, "a name in quotes, of at most %d bytes, expected here",
                      (int)sizeof out->name - 1);
        return false;
    }
    out->dimension = (int32_t)dimension;
    out->number = (int32_t)number;
    return true;
}

static bool read_names(ss_msh *r)
{
    int64_t count = 0;
    if (r->name != NULL) {
        ss_text_fault(r->text, "a second %s section: remove it", "$PhysicalNames");
        return false;
    }
    if (!read_count(r, "physical names", &count)) {
        return false;
    }
    if (count > SS_DRAFT_MAX_GROUPS) {
        ss_text_fault(r->text, "%lld physical names: at most %d are read", (long long)count,
                      (int)SS_DRAFT_MAX_GROUPS);
        return false;
    }
    r->name = ss_memory_get((size_t)count, sizeof *r->name);
    if (r->name == NULL) {
        return ss_text_out_of_memory(r->text);
    }
    for (; r->name_count < count; ++r->name_count) {
        if (!read_name(r, &r->name[r->name_count])) {
            return false;
        }
    }
    return ss_msh_expect_end(r, "$EndPhysicalNames");
}

/* ---- versions 1 and 2 ---- */

static bool read_node(ss_msh *r, int32_t index)
{
    ss_text_span line;
    double x[3];
    ss_draft_tag *tag = &r->draft->tag[index];
    if (!ss_text_next_line(r->text, &line)) {
        ss_text_fault(r->text, "the text ends at node %d of %d: the file is cut off", index,
                      r->draft->node_count);
        return false;
    }
    if (!ss_span_next_int64(&line, &tag->tag) || tag->tag < 1 ||
        !ss_span_next_number(&line, &x[0]) || !ss_span_next_number(&line, &x[1]) ||
        !ss_span_next_number(&line, &x[2]) || !ss_span_is_blank(line)) {
        ss_text_fault(r->text, "node %d: its number (1 or more) and x y z expected here", index);
        return false;
    }
    tag->index = index;
    tag->line = r->text->line;
    return ss_draft_put_node(r->draft, index, x);
}

static bool read_nodes(ss_msh *r, const char *end)
{
    int64_t count = 0;
    if (!read_count(r, "nodes", &count) || !ss_draft_make_nodes(r->draft, count, true)) {
        return false;
    }
    for (int32_t i = 0; i < count; ++i) {
        if (!read_node(r, i)) {
            return false;
        }
    }
    return ss_msh_expect_end(r, end) && ss_draft_sort_tags(r->draft);
}

/* The next element's line after its number and type. */
static bool begin_element(ss_msh *r, int64_t index, int64_t count, ss_text_span *out_line,
                          int64_t *out_type)
{
    int64_t number = 0;
    if (!ss_text_next_line(r->text, out_line)) {
        ss_text_fault(r->text, "the text ends at element %lld of %lld: the file is cut off",
                      (long long)index, (long long)count);
        return false;
    }
    if (!ss_span_next_int64(out_line, &number) || !ss_span_next_int32(out_line, out_type) ||
        *out_type < 1) {
        ss_text_fault(r->text, "element %lld: its number, type, tags and nodes expected here",
                      (long long)index);
        return false;
    }
    return true;
}

static bool count_kinds(ss_msh *r, int64_t count)
{
    for (int64_t i = 0; i < count; ++i) {
        ss_text_span line;
        int64_t type = 0;
        if (!begin_element(r, i, count, &line, &type)) {
            return false;
        }
        const ss_mesh_kind kind = ss_msh_kind(type);
        ++r->draft->found[kind];
        ss_msh_note_other(r, i, type);
    }
    return true;
}

/* The part of an element line between its type and its nodes: leaves the physical group. */
static bool read_tags(const ss_msh *r, ss_text_span *line, int nodes, int64_t *out_physical)
{
    int64_t skipped = 0;
    int64_t count = 0;
    *out_physical = 0;
    if (r->version == 1) {
        return ss_span_next_int32(line, out_physical) && ss_span_next_int32(line, &skipped) &&
               ss_span_next_int32(line, &count) && count == nodes;
    }
    if (!ss_span_next_int32(line, &count) || count < 0) {
        return false;
    }
    for (int64_t i = 0; i < count; ++i) {
        if (!ss_span_next_int32(line, i == 0 ? out_physical : &skipped)) {
            return false;
        }
    }
    return true;
}

/* Adds it to the mesh, its nodes to its group. */
static bool keep_element(ss_msh *r, ss_mesh_kind kind, int64_t physical, const int32_t *node)
{
    const int32_t group =
        physical > 0 ? ss_msh_find_group(r, ss_msh_dimension(kind), physical) : -1;
    if (physical > 0 && group < 0) {
        return false;
    }
    for (int k = 0; k < ss_draft_nodes(kind) && group >= 0; ++k) {
        if (!ss_draft_mark(r->draft, group, node[k])) {
            return false;
        }
    }
    return ss_draft_add_element(r->draft, kind, node, ss_mesh_edges_of_gmsh);
}

static bool read_element(ss_msh *r, int64_t index, int64_t count)
{
    ss_text_span line;
    int64_t type = 0;
    if (!begin_element(r, index, count, &line, &type)) {
        return false;
    }
    const ss_mesh_kind kind = ss_msh_kind(type);
    const int nodes = ss_draft_nodes(kind);
    if (nodes == 0) {
        return true;
    }
    int64_t physical = 0;
    int32_t node[SS_DRAFT_MAX_NODES] = {0};
    bool is_good = read_tags(r, &line, nodes, &physical);
    for (int k = 0; k < nodes && is_good; ++k) {
        int64_t tag = 0;
        is_good = ss_span_next_int64(&line, &tag);
        node[k] = is_good ? ss_msh_find_node(r, index, tag) : -1;
        if (is_good && node[k] < 0) {
            return r->text->fault_count < SS_TEXT_MAX_FAULTS;
        }
    }
    if (!is_good || !ss_span_is_blank(line)) {
        ss_text_fault(r->text,
                      "element %lld, a %s: its tags and then %d node numbers expected here",
                      (long long)index, ss_msh_type_name(type), nodes);
        return false;
    }
    return keep_element(r, kind, physical, node);
}

static bool read_elements(ss_msh *r, const char *end)
{
    int64_t count = 0;
    if (!read_count(r, "elements", &count)) {
        return false;
    }
    const ss_text_mark start = ss_text_here(r->text);
    if (!count_kinds(r, count) || !ss_msh_begin_elements(r, start)) {
        return false;
    }
    for (int64_t i = 0; i < count; ++i) {
        if (!read_element(r, i, count)) {
            return false;
        }
    }
    return ss_msh_expect_end(r, end);
}

/* ---- the file ---- */

/* Sections of no concern to us: to their end, $End followed by the name. */
static bool skip_section(ss_msh *r, ss_text_span name)
{
    ss_text_span line;
    char end[64];
    const int32_t start = r->text->line;
    const int length = (int)(name.end - name.begin) - 1;
    const int written = snprintf(end, sizeof end, "$End%.*s", length, name.begin + 1);
    while (written < (int)sizeof end && ss_text_next_line(r->text, &line)) {
        if (ss_span_is(line, end)) {
            return true;
        }
    }
    r->text->line = start;
    ss_text_fault(r->text, "the section that starts here has no end: the file is cut off");
    return false;
}

static bool starts_nodes(ss_msh *r)
{
    if (r->draft->position != NULL) {
        ss_text_fault(r->text, "a second section of %s: write one mesh per file", "nodes");
        return false;
    }
    return true;
}

static bool starts_elements(ss_msh *r)
{
    if (r->has_elements || r->draft->position == NULL) {
        ss_text_fault(r->text, "a section of elements %s: write one mesh per file, nodes first",
                      r->has_elements ? "again" : "before the nodes");
        return false;
    }
    r->has_elements = true;
    return true;
}

static bool refuse_parts(ss_msh *r)
{
    ss_text_fault(r->text, "a mesh in partitions is not read: write it whole "
                           "(gmsh -save -format msh22 IN.msh -o OUT.msh)");
    return false;
}

static bool read_section(ss_msh *r, ss_text_span line)
{
    const bool is_four = r->version == 4;
    const bool is_one = r->version == 1;
    if (ss_span_is(line, "$MeshFormat")) {
        return read_format(r);
    }
    if (ss_span_is(line, "$PhysicalNames")) {
        return read_names(r);
    }
    if (is_four && ss_span_is(line, "$Entities")) {
        return ss_msh4_read_entities(r);
    }
    if (is_four && ss_span_is(line, "$PartitionedEntities")) {
        return refuse_parts(r);
    }
    if (ss_span_is(line, "$Nodes") || ss_span_is(line, "$NOD")) {
        return starts_nodes(r) &&
               (is_four ? ss_msh4_read_nodes(r) : read_nodes(r, is_one ? "$ENDNOD" : "$EndNodes"));
    }
    if (ss_span_is(line, "$Elements") || ss_span_is(line, "$ELM")) {
        return starts_elements(r) &&
               (is_four ? ss_msh4_read_elements(r)
                        : read_elements(r, is_one ? "$ENDELM" : "$EndElements"));
    }
    return skip_section(r, line);
}

static bool read_sections(ss_msh *r)
{
    ss_text_span line;
    while (ss_text_next_line(r->text, &line)) {
        if (*line.begin != '$') {
            ss_text_fault(r->text, "a section such as %s expected here", "$Nodes");
            return false;
        }
        const bool is_old = ss_span_is(line, "$NOD") || ss_span_is(line, "$ELM");
        const bool is_new = ss_span_is(line, "$Nodes") || ss_span_is(line, "$Elements");
        if (is_old && r->version == 0) {
            r->version = 1;
        }
        if ((is_old && r->version != 1) || (is_new && r->version < 2)) {
            ss_text_fault(r->text, "this section does not belong to a file of version %s",
                          r->version > 1 ? "2 or 4" : "1, or $MeshFormat is missing before it");
            return false;
        }
        if (!read_section(r, line)) {
            return false;
        }
    }
    if (r->text->fault_count == 0 && !r->has_elements) {
        ss_text_fault_file(r->text, SOFTSIM_ERROR_FORMAT,
                           "no section of elements: the file is cut off or not a mesh");
    }
    return r->text->fault_count == 0;
}

softsim_status ss_mesh_parse_msh(ss_text *text, double metres_per_unit, ss_mesh **out_mesh)
{
    *out_mesh = NULL;
    ss_msh r = {.text = text, .draft = ss_draft_create(text, metres_per_unit)};
    if (r.draft != NULL && read_sections(&r)) {
        name_groups(&r);
        (void)ss_draft_finish(r.draft, out_mesh);
    }
    ss_draft_destroy(&r.draft);
    SS_EACH(ss_memory_free, r.name, r.entity, r.group);
    return text->status;
}

softsim_status ss_mesh_read_msh(const char *text, size_t size, const char *name,
                                double metres_per_unit, ss_mesh **out_mesh, softsim_error *error)
{
    ss_text source;
    ss_text_init(&source, text, size, name, error);
    return ss_mesh_parse_msh(&source, metres_per_unit, out_mesh);
}

static bool sniff(const char *start)
{
    return *start == '$';
}

static softsim_status read_mesh(const ss_mesh_file *file, ss_mesh **out_mesh)
{
    return ss_mesh_read_text(file, ss_mesh_parse_msh, out_mesh);
}

extern const ss_mesh_reader ss_mesh_reader_msh;
const ss_mesh_reader ss_mesh_reader_msh = {
    .name = "Gmsh MSH (ASCII)", .sniff = sniff, .read = read_mesh};
