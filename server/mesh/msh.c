/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Reader of Gmsh MSH text, versions 2.0 to 2.2 and 1, line by line.
 *
 *   $MeshFormat / 2.2 0 8 / $EndMeshFormat              (version 1 has none: $NOD, $ELM)
 *   $PhysicalNames / n / dimension number "name" ...
 *   $Nodes / n / tag x y z ...
 *   $Elements / n / tag type tag-count physical ... nodes   (1: tag type physical region n nodes)
 *
 * Nodes and elements are numbered from 0 in the order of the file; tags may be any positive
 * numbers with any gaps. Triangles, quads and tetrahedra are kept; points and lines only name nodes
 * for their physical group; anything else is refused. With tetrahedra the file's triangles and
 * quads only serve the groups and the surface is extracted from the tetrahedra. Quads beside
 * triangles are cut in two, at their place in the file's order.
 *
 * Nothing in the text is trusted: a count larger than the rest of the text could hold is refused
 * before anything is allocated, so memory stays within a small multiple of the file. The whole
 * text is in memory; a streaming parser would save that but could not bound counts beforehand.
 */
#include "mesh/mesh.h"
#include "mesh/topology.h"
#include "rt/memory.h"
#include "rt/vec.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_COUNT = 64 * 1024 * 1024, /* nodes, or elements */
    MIN_RECORD = 7,               /* bytes of the shortest line of a node or element, "1 0 0 0" */
    MAX_GROUPS = 1024,
    MAX_FAULTS = 5, /* of lines; then reading stops */
    MAX_NUMBER = 63 /* characters of a number */
};

typedef struct text_span {
    const char *begin, *end;
} text_span;

typedef struct tagged {
    int64_t tag;
    int32_t index;
    int32_t line;
} tagged;

typedef struct element {
    int32_t node[4];
    int32_t physical; /* 0: none */
    int8_t type;
} element;

typedef struct physical_name {
    int32_t dimension, number;
    char name[64];
} physical_name;

/* A physical group in use: sorted by dimension and number. */
typedef struct physical {
    int32_t dimension, number;
    int32_t group; /* of the mesh: groups of one name are one */
} physical;

typedef struct reader {
    const char *at, *end;
    const char *name;
    softsim_error *error;
    double metres_per_unit;
    int32_t line;
    int32_t fault_count;
    int version; /* 0 until known, 1, 2 */
    double (*position)[3];
    tagged *tag; /* sorted */
    int32_t node_count;
    element *element;
    int32_t element_count;
    bool has_elements;
    physical_name *names;
    int32_t name_count;
    physical physical[MAX_GROUPS];
    int32_t physical_count;
} reader;

/* ---- lines, words, numbers --------------------------------------------------------------------
 */

#define FAULT(r, status, ...)                                                                      \
    do {                                                                                           \
        ++(r)->fault_count;                                                                        \
        softsim_error_add((r)->error, (status), __VA_ARGS__);                                      \
    } while (false)
#define FAULT_LINE(r, text, ...)                                                                   \
    FAULT(r, SOFTSIM_ERROR_FORMAT, "%s:%d: " text, (r)->name, (r)->line, __VA_ARGS__)

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}

/* The next line that is not blank, without surrounding blanks; false at the end of the text. */
static bool next_line(reader *r, text_span *out)
{
    while (r->at < r->end) {
        const char *newline = memchr(r->at, '\n', (size_t)(r->end - r->at));
        out->begin = r->at;
        out->end = newline != NULL ? newline : r->end;
        r->at = newline != NULL ? newline + 1 : r->end;
        ++r->line;
        while (out->begin < out->end && is_space(*out->begin)) {
            ++out->begin;
        }
        while (out->end > out->begin && is_space(out->end[-1])) {
            --out->end;
        }
        if (out->begin < out->end) {
            return true;
        }
    }
    return false;
}

/* Takes the next word off `line`; false when there is none. */
static bool next_word(text_span *line, text_span *out)
{
    while (line->begin < line->end && is_space(*line->begin)) {
        ++line->begin;
    }
    out->begin = line->begin;
    while (line->begin < line->end && !is_space(*line->begin)) {
        ++line->begin;
    }
    out->end = line->begin;
    return out->begin < out->end;
}

static bool is_word(text_span word, const char *text)
{
    const size_t length = strlen(text);
    return (size_t)(word.end - word.begin) == length && memcmp(word.begin, text, length) == 0;
}

/* Within 32 bits, so that no sum of a few overflows. */
static bool next_integer(text_span *line, int64_t *out)
{
    text_span word;
    if (!next_word(line, &word)) {
        return false;
    }
    const bool is_negative = *word.begin == '-';
    word.begin += is_negative || *word.begin == '+';
    int64_t value = 0;
    const char *digit = word.begin;
    for (; digit < word.end && *digit >= '0' && *digit <= '9' && value <= INT32_MAX; ++digit) {
        value = 10 * value + (*digit - '0');
    }
    if (digit != word.end || digit == word.begin || value > INT32_MAX) {
        return false;
    }
    *out = is_negative ? -value : value;
    return true;
}

static bool next_number(text_span *line, double *out)
{
    text_span word;
    char buffer[MAX_NUMBER + 1];
    if (!next_word(line, &word) || word.end - word.begin > MAX_NUMBER) {
        return false;
    }
    const size_t length = (size_t)(word.end - word.begin);
    memcpy(buffer, word.begin, length);
    buffer[length] = '\0';
    char *stop = NULL;
    *out = strtod(buffer, &stop);
    return stop == buffer + length;
}

static bool is_at_end(text_span line)
{
    text_span word;
    return !next_word(&line, &word);
}

/* ---- sections ---------------------------------------------------------------------------------
 */

static bool expect_end(reader *r, const char *end)
{
    text_span line;
    if (!next_line(r, &line)) {
        FAULT_LINE(r, "the text ends before %s: the file is cut off, copy or write it again", end);
        return false;
    }
    if (!is_word(line, end)) {
        FAULT_LINE(r, "%s expected here: the count at the start of the section does not fit it",
                   end);
        return false;
    }
    return true;
}

/* The line with the number of records, which the rest of the text must be able to hold. */
static bool read_count(reader *r, const char *what, int32_t *out)
{
    text_span line;
    int64_t count = 0;
    if (!next_line(r, &line) || !next_integer(&line, &count) || !is_at_end(line) || count < 0) {
        FAULT_LINE(r, "the number of %s expected here, alone on its line", what);
        return false;
    }
    const int64_t room = (r->end - r->at) / MIN_RECORD + 1;
    if (count > room || count > MAX_COUNT) {
        FAULT_LINE(r, "%lld %s announced, but %s: the file is damaged or cut off", (long long)count,
                   what,
                   count > MAX_COUNT ? "more than 67 million are not read"
                                     : "the rest of the file is too short for them");
        return false;
    }
    *out = (int32_t)count;
    return true;
}

static bool out_of_memory(reader *r)
{
    FAULT(r, SOFTSIM_ERROR_MEMORY, "%s: out of memory", r->name);
    return false;
}

static bool read_format(reader *r)
{
    text_span line;
    double version = 0.0;
    int64_t is_binary = 0;
    int64_t size = 0;
    if (!next_line(r, &line) || !next_number(&line, &version) || !next_integer(&line, &is_binary) ||
        !next_integer(&line, &size)) {
        FAULT_LINE(r, "a line such as \"%s\" expected here", "2.2 0 8");
        return false;
    }
    if (is_binary != 0 || !(version >= 2.0 && version < 3.0)) {
        FAULT_LINE(r,
                   "Gmsh format %g%s is not read: write the mesh as version 2.2 ASCII "
                   "(gmsh -save -format msh22 IN.msh -o OUT.msh)",
                   version, is_binary != 0 ? " binary" : "");
        return false;
    }
    r->version = 2;
    return expect_end(r, "$EndMeshFormat");
}

static bool read_names(reader *r)
{
    int32_t count = 0;
    if (r->names != NULL) {
        FAULT_LINE(r, "a second %s section: remove it", "$PhysicalNames");
        return false;
    }
    if (!read_count(r, "physical names", &count)) {
        return false;
    }
    if (count > MAX_GROUPS) {
        FAULT_LINE(r, "%d physical names: at most %d are read", count, MAX_GROUPS);
        return false;
    }
    r->names = ss_memory_get((size_t)count, sizeof *r->names);
    if (r->names == NULL) {
        return out_of_memory(r);
    }
    for (; r->name_count < count; ++r->name_count) {
        physical_name *name = &r->names[r->name_count];
        text_span line;
        int64_t dimension = 0;
        int64_t number = 0;
        if (!next_line(r, &line) || !next_integer(&line, &dimension) ||
            !next_integer(&line, &number) || dimension < 0 || dimension > 3) {
            FAULT_LINE(r, "a line such as %s expected here", "2 1 \"name\"");
            return false;
        }
        const char *open = memchr(line.begin, '"', (size_t)(line.end - line.begin));
        if (open == NULL || line.end - open < 2 || line.end[-1] != '"' ||
            (size_t)(line.end - open - 2) >= sizeof name->name ||
            memchr(open, '\0', (size_t)(line.end - open)) != NULL) {
            FAULT_LINE(r, "a name in quotes, of at most %d bytes, expected here",
                       (int)sizeof name->name - 1);
            return false;
        }
        name->dimension = (int32_t)dimension;
        name->number = (int32_t)number;
        memcpy(name->name, open + 1, (size_t)(line.end - open - 2));
    }
    return expect_end(r, "$EndPhysicalNames");
}

static int compare_tags(const void *left, const void *right)
{
    const tagged *a = left;
    const tagged *b = right;
    if (a->tag != b->tag) {
        return a->tag < b->tag ? -1 : 1;
    }
    return (a->index > b->index) - (a->index < b->index);
}

static bool read_node(reader *r, int32_t index)
{
    text_span line;
    double *x = r->position[index];
    if (!next_line(r, &line)) {
        FAULT_LINE(r, "the text ends at node %d of %d: the file is cut off", index, r->node_count);
        return false;
    }
    if (!next_integer(&line, &r->tag[index].tag) || r->tag[index].tag < 1 ||
        !next_number(&line, &x[0]) || !next_number(&line, &x[1]) || !next_number(&line, &x[2]) ||
        !is_at_end(line)) {
        FAULT_LINE(r, "node %d: its number (1 or more) and x y z expected here", index);
        return false;
    }
    ss_scale3(x, x, r->metres_per_unit);
    if (!ss_is_finite(x, 3)) {
        FAULT_LINE(r, "node %d: its position is not finite: correct it", index);
    }
    r->tag[index].index = index;
    r->tag[index].line = r->line;
    return r->fault_count < MAX_FAULTS;
}

static bool read_nodes(reader *r, const char *end)
{
    if (r->position != NULL) {
        FAULT_LINE(r, "a second section of %s: write one mesh per file", "nodes");
        return false;
    }
    if (!read_count(r, "nodes", &r->node_count)) {
        return false;
    }
    r->position = ss_memory_get((size_t)r->node_count, sizeof *r->position);
    r->tag = ss_memory_get((size_t)r->node_count, sizeof *r->tag);
    if (r->position == NULL || r->tag == NULL) {
        return out_of_memory(r);
    }
    for (int32_t i = 0; i < r->node_count; ++i) {
        if (!read_node(r, i)) {
            return false;
        }
    }
    if (!expect_end(r, end)) {
        return false;
    }
    qsort(r->tag, (size_t)r->node_count, sizeof *r->tag, compare_tags);
    for (int32_t i = 1; i < r->node_count && r->fault_count < MAX_FAULTS; ++i) {
        if (r->tag[i].tag == r->tag[i - 1].tag) {
            FAULT(r, SOFTSIM_ERROR_FORMAT,
                  "%s:%d: node number %lld is on line %d already: number nodes uniquely", r->name,
                  r->tag[i].line, (long long)r->tag[i].tag, r->tag[i - 1].line);
        }
    }
    return true;
}

/* Index of the node with `tag`, -1 when there is none. */
static int32_t find_node(const reader *r, int64_t tag)
{
    /* Files numbered 1, 2, 3 ... need no search. */
    if (tag >= 1 && tag <= r->node_count && r->tag[tag - 1].tag == tag) {
        return r->tag[tag - 1].index;
    }
    int32_t low = 0;
    int32_t high = r->node_count;
    while (low < high) {
        const int32_t middle = low + (high - low) / 2;
        if (r->tag[middle].tag < tag) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < r->node_count && r->tag[low].tag == tag ? r->tag[low].index : -1;
}

enum { TYPE_LINE = 1, TYPE_TRIANGLE = 2, TYPE_QUAD = 3, TYPE_TETRAHEDRON = 4, TYPE_POINT = 15 };

/* Nodes of the element types that are read; 0 for others. */
static int type_nodes(int64_t type)
{
    return type == TYPE_POINT         ? 1
           : type == TYPE_LINE        ? 2
           : type == TYPE_TRIANGLE    ? 3
           : type == TYPE_QUAD        ? 4
           : type == TYPE_TETRAHEDRON ? 4
                                      : 0;
}

static const char *type_name(int64_t type)
{
    static const char *const names[] = {"",
                                        "line",
                                        "triangle",
                                        "quadrangle",
                                        "tetrahedron",
                                        "hexahedron",
                                        "prism",
                                        "pyramid",
                                        "second-order line",
                                        "second-order triangle",
                                        "second-order quadrangle",
                                        "second-order tetrahedron"};
    return type > 0 && type < (int64_t)(sizeof names / sizeof names[0]) ? names[type]
                                                                        : "not a triangle";
}

/* The part of an element line between its type and its nodes: leaves the physical group. */
static bool read_element_tags(reader *r, text_span *line, int64_t *out_physical)
{
    int64_t skipped = 0;
    *out_physical = 0;
    if (r->version == 1) {
        int64_t node_count = 0;
        return next_integer(line, out_physical) && next_integer(line, &skipped) &&
               next_integer(line, &node_count);
    }
    int64_t count = 0;
    if (!next_integer(line, &count) || count < 0) {
        return false;
    }
    for (int64_t i = 0; i < count; ++i) {
        if (!next_integer(line, i == 0 ? out_physical : &skipped)) {
            return false;
        }
    }
    return true;
}

static bool read_element(reader *r, int32_t index)
{
    text_span line;
    int64_t number = 0;
    int64_t type = 0;
    int64_t group = 0;
    element *e = &r->element[index];
    if (!next_line(r, &line)) {
        FAULT_LINE(r, "the text ends at element %d of %d: the file is cut off", index,
                   r->element_count);
        return false;
    }
    if (!next_integer(&line, &number) || !next_integer(&line, &type)) {
        FAULT_LINE(r, "element %d: its number, type, tags and nodes expected here", index);
        return false;
    }
    const int count = type_nodes(type);
    if (count == 0) {
        FAULT_LINE(r,
                   "element %d is of type %lld (%s): only triangles, quadrangles and tetrahedra of "
                   "first order are read, mesh it so",
                   index, (long long)type, type_name(type));
        return r->fault_count < MAX_FAULTS;
    }
    e->type = (int8_t)type;
    bool is_good = read_element_tags(r, &line, &group);
    for (int k = 0; k < count && is_good; ++k) {
        int64_t tag = 0;
        is_good = next_integer(&line, &tag);
        e->node[k] = is_good ? find_node(r, tag) : -1;
        if (is_good && e->node[k] < 0) {
            FAULT_LINE(r, "element %d: there is no node number %lld: correct it or add the node",
                       index, (long long)tag);
            return r->fault_count < MAX_FAULTS;
        }
    }
    if (!is_good || !is_at_end(line)) {
        FAULT_LINE(r, "element %d, a %s: its tags and then %d node numbers expected here", index,
                   type_name(type), count);
        return false;
    }
    e->physical = group > 0 ? (int32_t)group : 0;
    return true;
}

static bool read_elements(reader *r, const char *end)
{
    if (r->has_elements || r->position == NULL) {
        FAULT_LINE(r, "a section of elements %s: write one mesh per file, nodes first",
                   r->has_elements ? "again" : "before the nodes");
        return false;
    }
    r->has_elements = true;
    if (!read_count(r, "elements", &r->element_count)) {
        return false;
    }
    r->element = ss_memory_get((size_t)r->element_count, sizeof *r->element);
    if (r->element == NULL) {
        return out_of_memory(r);
    }
    for (int32_t i = 0; i < r->element_count; ++i) {
        if (!read_element(r, i)) {
            return false;
        }
    }
    return expect_end(r, end);
}

/* Sections of no concern to us: to their end, $End followed by the name. */
static bool skip_section(reader *r, text_span name)
{
    text_span line;
    const int32_t start = r->line;
    const size_t length = (size_t)(name.end - name.begin) - 1;
    while (next_line(r, &line)) {
        if ((size_t)(line.end - line.begin) == length + 4 && memcmp(line.begin, "$End", 4) == 0 &&
            memcmp(line.begin + 4, name.begin + 1, length) == 0) {
            return true;
        }
    }
    FAULT(r, SOFTSIM_ERROR_FORMAT,
          "%s:%d: the section that starts here has no end: the file is cut off", r->name, start);
    return false;
}

static bool read_sections(reader *r)
{
    text_span line;
    while (next_line(r, &line)) {
        if (*line.begin != '$') {
            FAULT_LINE(r, "a section such as %s expected here", "$Nodes");
            return false;
        }
        const bool is_old = is_word(line, "$NOD") || is_word(line, "$ELM");
        const bool is_new = is_word(line, "$Nodes") || is_word(line, "$Elements");
        if (is_old && r->version == 0) {
            r->version = 1;
        }
        if ((is_old && r->version != 1) || (is_new && r->version != 2)) {
            FAULT_LINE(r, "this section does not belong to a file of version %s",
                       r->version == 2 ? "2" : "1, or $MeshFormat is missing before it");
            return false;
        }
        const bool is_read = is_word(line, "$MeshFormat")      ? read_format(r)
                             : is_word(line, "$PhysicalNames") ? read_names(r)
                             : is_word(line, "$Nodes")         ? read_nodes(r, "$EndNodes")
                             : is_word(line, "$NOD")           ? read_nodes(r, "$ENDNOD")
                             : is_word(line, "$Elements")      ? read_elements(r, "$EndElements")
                             : is_word(line, "$ELM")           ? read_elements(r, "$ENDELM")
                                                               : skip_section(r, line);
        if (!is_read) {
            return false;
        }
    }
    return r->fault_count == 0;
}

/* ---- groups -----------------------------------------------------------------------------------
 */

static int32_t dimension_of(const element *e)
{
    return e->type == TYPE_POINT         ? 0
           : e->type == TYPE_LINE        ? 1
           : e->type == TYPE_TETRAHEDRON ? 3
                                         : 2;
}

/* Where (dimension, number) is in the sorted list, or where it belongs. */
static int32_t find_physical(const reader *r, int32_t dimension, int32_t number)
{
    int32_t low = 0;
    int32_t high = r->physical_count;
    while (low < high) {
        const int32_t middle = (low + high) / 2;
        const physical *p = &r->physical[middle];
        if (p->dimension < dimension || (p->dimension == dimension && p->number < number)) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

static bool list_physicals(reader *r)
{
    for (int32_t i = 0; i < r->element_count; ++i) {
        const int32_t number = r->element[i].physical;
        const int32_t dimension = dimension_of(&r->element[i]);
        const int32_t at = number > 0 ? find_physical(r, dimension, number) : 0;
        if (number <= 0 || (at < r->physical_count && r->physical[at].dimension == dimension &&
                            r->physical[at].number == number)) {
            continue;
        }
        if (r->physical_count == MAX_GROUPS) {
            FAULT(r, SOFTSIM_ERROR_FORMAT, "%s: more than %d physical groups: use fewer", r->name,
                  MAX_GROUPS);
            return false;
        }
        memmove(&r->physical[at + 1], &r->physical[at],
                (size_t)(r->physical_count - at) * sizeof r->physical[0]);
        r->physical[at] = (physical){.dimension = dimension, .number = number};
        ++r->physical_count;
    }
    return true;
}

/* The file's name, or "surface-2" and the like. */
static void name_physical(const reader *r, const physical *p, char out[64])
{
    static const char *const kinds[] = {"point", "line", "surface", "volume"};
    for (int32_t i = 0; i < r->name_count; ++i) {
        if (r->names[i].dimension == p->dimension && r->names[i].number == p->number) {
            memcpy(out, r->names[i].name, sizeof r->names[i].name);
            return;
        }
    }
    (void)snprintf(out, 64, "%s-%d", kinds[p->dimension], p->number);
}

static void name_groups(reader *r, ss_mesh *mesh)
{
    for (int32_t p = 0; p < r->physical_count; ++p) {
        char name[64];
        name_physical(r, &r->physical[p], name);
        int32_t g = 0;
        while (g < mesh->group_count && strcmp(mesh->group[g].name, name) != 0) {
            ++g;
        }
        if (g == mesh->group_count) {
            memcpy(mesh->group[g].name, name, sizeof name);
            ++mesh->group_count;
        }
        r->physical[p].group = g;
    }
}

static int32_t group_of(const reader *r, const element *e)
{
    if (e->physical <= 0) {
        return -1;
    }
    return r->physical[find_physical(r, dimension_of(e), e->physical)].group;
}

/* Nodes of group g in increasing order: marks, then gathers. `order` lists the elements of g. */
static bool fill_group(const reader *r, ss_mesh_group *group, const int32_t *order, int64_t count,
                       int32_t *stamp, int32_t mark)
{
    int32_t lowest = r->node_count;
    int32_t highest = -1;
    for (int64_t i = 0; i < count; ++i) {
        const element *e = &r->element[order[i]];
        for (int k = 0; k < type_nodes(e->type); ++k) {
            const int32_t node = e->node[k];
            group->node_count += stamp[node] != mark;
            stamp[node] = mark;
            lowest = node < lowest ? node : lowest;
            highest = node > highest ? node : highest;
        }
    }
    group->node = ss_memory_get((size_t)group->node_count, sizeof *group->node);
    if (group->node == NULL) {
        return false;
    }
    int32_t filled = 0;
    for (int32_t node = lowest; node <= highest; ++node) {
        if (stamp[node] == mark) {
            group->node[filled++] = node;
        }
    }
    return true;
}

static bool build_groups(reader *r, ss_mesh *mesh)
{
    if (!list_physicals(r)) {
        return false;
    }
    int32_t *stamp = ss_memory_get((size_t)r->node_count, sizeof *stamp);
    int32_t *order = ss_memory_get((size_t)r->element_count, sizeof *order);
    int64_t *start = ss_memory_get((size_t)r->physical_count + 2, sizeof *start);
    mesh->group = ss_memory_get((size_t)r->physical_count, sizeof *mesh->group);
    bool is_done = stamp != NULL && order != NULL && start != NULL && mesh->group != NULL;
    if (is_done) {
        name_groups(r, mesh);
        /* Elements by group: counts one place on, sums, fill. */
        for (int32_t i = 0; i < r->element_count; ++i) {
            ++start[group_of(r, &r->element[i]) + 2];
        }
        for (int32_t g = 0; g <= mesh->group_count; ++g) {
            start[g + 1] += start[g];
        }
        for (int32_t i = 0; i < r->element_count; ++i) {
            order[start[group_of(r, &r->element[i]) + 1]++] = i;
        }
        for (int32_t g = 0; g < mesh->group_count && is_done; ++g) {
            is_done = fill_group(r, &mesh->group[g], order + start[g], start[g + 1] - start[g],
                                 stamp, g + 1);
        }
    }
    ss_memory_free(stamp);
    ss_memory_free(order);
    ss_memory_free(start);
    return is_done ? true : out_of_memory(r);
}

/* ---- the mesh ---------------------------------------------------------------------------------
 */

/* The elements by kind. */
typedef struct element_lists {
    int32_t (*triangle)[3], (*quad)[4], (*tetrahedron)[4];
    int32_t triangles, quads, tetrahedra;
} element_lists;

/* Quads are cut where the surface has triangles too: file order, two triangles for each quad. */
static void fill_lists(const reader *r, bool is_mixed, element_lists *out)
{
    const ss_mesh nodes = {.node_count = r->node_count, .position = r->position};
    for (int32_t i = 0; i < r->element_count; ++i) {
        const element *e = &r->element[i];
        if (e->type == TYPE_TRIANGLE) {
            memcpy(out->triangle[out->triangles++], e->node, sizeof *out->triangle);
        } else if (e->type == TYPE_QUAD && is_mixed) {
            ss_mesh_cut_quad(&nodes, e->node, &out->triangle[out->triangles]);
            out->triangles += 2;
            ++out->quads;
        } else if (e->type == TYPE_QUAD) {
            memcpy(out->quad[out->quads++], e->node, sizeof *out->quad);
        } else if (e->type == TYPE_TETRAHEDRON) {
            memcpy(out->tetrahedron[out->tetrahedra++], e->node, sizeof *out->tetrahedron);
        }
    }
}

static softsim_status create_mesh(const reader *r, const element_lists *lists, ss_mesh **out_mesh)
{
    const double(*position)[3] = (const double(*)[3])r->position;
    if (lists->tetrahedra == 0 && lists->triangles == 0) {
        return ss_mesh_create_quads(r->node_count, position, lists->quads,
                                    (const int32_t(*)[4])lists->quad, out_mesh, r->error);
    }
    const bool is_volume = lists->tetrahedra > 0;
    const softsim_status status =
        ss_mesh_create(r->node_count, position, is_volume ? 0 : lists->triangles,
                       (const int32_t(*)[3])lists->triangle, lists->tetrahedra,
                       (const int32_t(*)[4])lists->tetrahedron, out_mesh, r->error);
    if (status == SOFTSIM_OK && !is_volume) {
        (*out_mesh)->cut_face_count = lists->quads;
    }
    return status;
}

static softsim_status build_mesh(reader *r, ss_mesh **out_mesh)
{
    int32_t triangles = 0;
    int32_t quads = 0;
    int32_t tetrahedra = 0;
    for (int32_t i = 0; i < r->element_count; ++i) {
        triangles += r->element[i].type == TYPE_TRIANGLE;
        quads += r->element[i].type == TYPE_QUAD;
        tetrahedra += r->element[i].type == TYPE_TETRAHEDRON;
    }
    const bool is_mixed = quads > 0 && triangles > 0 && tetrahedra == 0;
    element_lists lists = {0};
    lists.triangle = ss_memory_get((size_t)triangles + (is_mixed ? 2 * (size_t)quads : 0),
                                   sizeof *lists.triangle);
    lists.quad = ss_memory_get((size_t)quads, sizeof *lists.quad);
    lists.tetrahedron = ss_memory_get((size_t)tetrahedra, sizeof *lists.tetrahedron);
    softsim_status status = SOFTSIM_ERROR_FORMAT;
    if (lists.triangle == NULL || lists.quad == NULL || lists.tetrahedron == NULL) {
        (void)out_of_memory(r);
        status = SOFTSIM_ERROR_MEMORY;
    } else if (r->node_count == 0 || triangles + quads + tetrahedra == 0) {
        FAULT(r, SOFTSIM_ERROR_FORMAT, "%s: no triangles, quads or tetrahedra in it: mesh it first",
              r->name);
    } else {
        fill_lists(r, is_mixed, &lists);
        status = create_mesh(r, &lists, out_mesh);
        if (status == SOFTSIM_OK && !build_groups(r, *out_mesh)) {
            ss_mesh_destroy(out_mesh);
            status = SOFTSIM_ERROR_FORMAT;
        }
    }
    ss_memory_free(lists.triangle);
    ss_memory_free(lists.quad);
    ss_memory_free(lists.tetrahedron);
    return status;
}

softsim_status ss_mesh_read_msh(const char *text, size_t size, const char *name,
                                double metres_per_unit, ss_mesh **out_mesh, softsim_error *error)
{
    *out_mesh = NULL;
    reader *r = ss_memory_get(1, sizeof *r);
    if (r == NULL) {
        softsim_error_add(error, SOFTSIM_ERROR_MEMORY, "%s: out of memory", name);
        return SOFTSIM_ERROR_MEMORY;
    }
    r->at = text;
    r->end = text + size;
    r->name = name;
    r->error = error;
    r->metres_per_unit = metres_per_unit;

    softsim_status status = SOFTSIM_ERROR_FORMAT;
    if (read_sections(r)) {
        if (r->has_elements) {
            status = build_mesh(r, out_mesh);
        } else {
            FAULT(r, SOFTSIM_ERROR_FORMAT,
                  "%s: no section of elements: the file is cut off or not a mesh", name);
        }
    }
    ss_memory_free(r->position);
    ss_memory_free(r->tag);
    ss_memory_free(r->element);
    ss_memory_free(r->names);
    ss_memory_free(r);
    return status;
}
