/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * softsim-import FILE: reads a surface with assimp and writes its faces to stdout as mesh/import.h
 * says: quads when all are quads, else triangles, which assimp cuts. A program of its own because
 * assimp ends the process or never returns on some damaged files: it sets itself limits on memory
 * and CPU time before it opens anything.
 *
 * Vertices are joined where their positions are equal, across all the file's meshes. (assimp's own
 * joining stays within one mesh, so that a body of two materials would fall apart, and takes a NaN
 * for equal to anything.) Those of an OBJ file keep
 * the file's order and digits (obj.h), the others assimp's: that in which faces first use
 * them. Vertices without a face are left out. Normals, texture coordinates and the like are
 * removed first, or they would keep vertices apart.
 */
#include "mesh/import.h"
#include "beside.h"
#include "obj.h"
#include "ply.h"
#include "rt/hash.h"
#include "rt/plain.h"
#include "rt/program.h"
#include "stl.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define IS_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) ||                         \
    __has_feature(memory_sanitizer)
#define IS_SANITIZED 1
#endif
#endif
#ifndef IS_SANITIZED
#define IS_SANITIZED 0
#endif

/* Before joining: `position` as read, faces of `corners` numbers into it. */
typedef struct surface {
    double (*position)[3];
    int32_t *node;
    unsigned corners; /* 3 or 4 */
    int64_t node_count, face_count;
    int64_t cut_face_count;
    int64_t joined_count, unused_count; /* of join_nodes */
} surface;

/* Of address space: the importer's own limit, or what is in force already where that is less. */
static rlim_t memory_limit(void)
{
    struct rlimit bytes;
    const rlim_t own = SS_IMPORT_MAX_BYTES;
    return getrlimit(RLIMIT_AS, &bytes) == 0 && bytes.rlim_cur < own ? bytes.rlim_cur : own;
}

static void set_limits(void)
{
    const rlim_t limit = memory_limit();
    const struct rlimit bytes = {limit, limit};
    /* The sanitizers reserve terabytes of address space. */
    if (!IS_SANITIZED) {
        (void)setrlimit(RLIMIT_AS, &bytes);
    }
    const struct rlimit seconds = {SS_IMPORT_MAX_CPU_S, SS_IMPORT_MAX_CPU_S};
    const struct rlimit none = {0, 0};
    (void)setrlimit(RLIMIT_CPU, &seconds);
    (void)setrlimit(RLIMIT_CORE, &none);
    (void)setrlimit(RLIMIT_RTPRIO, &none); /* a daemon of root's has raised it */
}

/* ---- reading ---- */

/* Of four letters. */
static bool has_ending(const char *path, const char *ending)
{
    const size_t length = strlen(path);
    return length >= 4 && strcasecmp(path + length - 4, ending) == 0;
}

enum { SHAPES = 6 };

/* How many faces have one corner (points), two (lines), three, four, more; none: [0]. */
static void count_faces(const struct aiScene *scene, int64_t out_count[SHAPES])
{
    memset(out_count, 0, SHAPES * sizeof *out_count);
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        for (unsigned f = 0; f < scene->mMeshes[m]->mNumFaces; ++f) {
            const unsigned corners = scene->mMeshes[m]->mFaces[f].mNumIndices;
            ++out_count[corners < SHAPES ? corners : SHAPES - 1];
        }
    }
}

/* Of a file without a face: what it holds. assimp's steps are not for such: they crash on scenes of
 * which they have removed all. */
static const char *no_face(const struct aiScene *scene, const int64_t count[SHAPES])
{
    static char text[160];
    int64_t vertices = 0;
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        vertices += scene->mMeshes[m]->mNumVertices;
    }
    const int64_t lines = count[2];
    const int64_t points = count[1] > 0 || lines > 0 ? count[1] : vertices;
    char of_lines[40] = "", of_points[40] = "";
    if (lines > 0) {
        (void)snprintf(of_lines, sizeof of_lines, "%lld lines and ", (long long)lines);
    }
    if (points > 0) {
        (void)snprintf(of_points, sizeof of_points, "%lld points and ", (long long)points);
    }
    (void)snprintf(text, sizeof text,
                   "it holds %s%sno triangle, so there is no body in it: give a surface", of_lines,
                   of_points);
    return text;
}

/* The colours of a prepared OBJ text are numbers. Faces are counted before anything is done to
 * them, and cut unless all are quads; s->corners tells. NULL: assimp or *out_problem says why. */
static const struct aiScene *read_scene(beside_files *files, const obj_text *obj, surface *s,
                                        const char **out_problem)
{
    struct aiPropertyStore *properties = aiCreatePropertyStore();
    aiSetImportPropertyInteger(properties, AI_CONFIG_PP_RVC_FLAGS,
                               aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS |
                                   aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS |
                                   aiComponent_ANIMATIONS | aiComponent_TEXTURES |
                                   aiComponent_LIGHTS | aiComponent_CAMERAS |
                                   aiComponent_MATERIALS | (obj == NULL ? aiComponent_COLORS : 0));
    aiSetImportPropertyInteger(properties, AI_CONFIG_PP_SBP_REMOVE,
                               aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const struct aiScene *scene =
        aiImportFileExWithProperties(files->path, 0, &files->io, properties);
    aiReleasePropertyStore(properties);
    if (scene == NULL) {
        return NULL;
    }
    int64_t faces[SHAPES];
    count_faces(scene, faces);
    if (faces[3] + faces[4] + faces[5] == 0) {
        *out_problem = no_face(scene, faces);
        return NULL;
    }
    const bool are_quads = faces[3] == 0 && faces[4] > 0 && faces[5] == 0;
    s->corners = are_quads ? 4 : 3;
    s->cut_face_count = are_quads ? 0 : faces[4] + faces[5];
    return aiApplyPostProcessing(scene, aiProcess_ValidateDataStructure |
                                            aiProcess_RemoveComponent | aiProcess_SortByPType |
                                            aiProcess_PreTransformVertices |
                                            (are_quads ? 0U : (unsigned)aiProcess_Triangulate));
}

static bool allocate(surface *s, const struct aiScene *scene, const obj_text *obj)
{
    int64_t nodes = 0;
    int64_t faces = 0;
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        nodes += scene->mMeshes[m]->mNumVertices;
        faces += scene->mMeshes[m]->mNumFaces;
    }
    if (nodes > INT32_MAX / 4 || faces > INT32_MAX / 4) {
        return false;
    }
    s->position = obj != NULL ? obj->position : calloc((size_t)nodes + 1, sizeof *s->position);
    s->node_count = obj != NULL ? obj->count : 0;
    s->node = calloc((size_t)faces + 1, s->corners * sizeof *s->node);
    return s->position != NULL && s->node != NULL;
}

/* Did assimp read vertex `number` where we read it? Both count vertex lines, and must agree. */
static bool is_same(const surface *s, int64_t number, const struct aiVector3D *v)
{
    const float x[3] = {v->x, v->y, v->z};
    for (int k = 0; k < 3; ++k) {
        const double expected = s->position[number][k];
        if (!(fabs((double)x[k] - expected) <= 1e-5 * fabs(expected) + 1e-30)) {
            return false;
        }
    }
    return true;
}

/* False when a face has vertices that do not exist. */
static bool add_mesh(surface *s, const struct aiMesh *mesh, const obj_text *obj)
{
    const int64_t base = s->node_count;
    if (obj != NULL && mesh->mNumFaces > 0 && mesh->mColors[0] == NULL) {
        return false;
    }
    for (unsigned v = 0; v < mesh->mNumVertices && obj == NULL; ++v) {
        const struct aiVector3D *x = &mesh->mVertices[v];
        double *out = s->position[s->node_count++];
        out[0] = (double)x->x;
        out[1] = (double)x->y;
        out[2] = (double)x->z;
    }
    for (unsigned f = 0; f < mesh->mNumFaces; ++f) {
        const struct aiFace *face = &mesh->mFaces[f];
        int32_t *node = s->node + s->corners * s->face_count++;
        for (unsigned k = 0; k < s->corners; ++k) {
            if (face->mNumIndices != s->corners || face->mIndices[k] >= mesh->mNumVertices) {
                return false;
            }
            int64_t number = base + face->mIndices[k];
            if (obj != NULL) {
                const struct aiColor4D *color = &mesh->mColors[0][face->mIndices[k]];
                number = obj_number(color->r, color->g, color->b);
            }
            if (number < 0 || number >= s->node_count ||
                (obj != NULL && !is_same(s, number, &mesh->mVertices[face->mIndices[k]]))) {
                return false;
            }
            node[k] = (int32_t)number;
        }
    }
    return true;
}

/* ---- joining ---- */

static uint64_t hash_position(const double x[3])
{
    uint64_t hash = SS_HASH_START;
    for (int k = 0; k < 3; ++k) {
        uint64_t bits;
        memcpy(&bits, &x[k], sizeof bits);
        hash = ss_hash_word(hash, bits);
    }
    return hash;
}

/* Numbers the positions that faces use, in order, equal ones (by their bits: NaN too) by one
 * number, and packs them. False when out of memory. */
static bool join_nodes(surface *s)
{
    uint64_t slots = 16;
    while (slots < 2 * (uint64_t)s->node_count) {
        slots *= 2;
    }
    int32_t *slot = malloc(slots * sizeof *slot); /* packed numbers by position, -1: free */
    int32_t *number = calloc((size_t)s->node_count + 1, sizeof *number);
    if (slot == NULL || number == NULL) {
        return false;
    }
    memset(slot, 0xff, slots * sizeof *slot);
    const int64_t corner_count = s->face_count * s->corners;
    for (int64_t i = 0; i < corner_count; ++i) {
        number[s->node[i]] = 1;
    }
    int32_t count = 0;
    for (int64_t i = 0; i < s->node_count; ++i) {
        if (number[i] == 0) {
            ++s->unused_count;
            continue;
        }
        const double *p = s->position[i];
        const double x[3] = {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}; /* -0 and 0 are one */
        uint64_t at = hash_position(x) & (slots - 1);
        while (slot[at] >= 0 && memcmp(s->position[slot[at]], x, sizeof x) != 0) {
            at = (at + 1) & (slots - 1);
        }
        if (slot[at] < 0) {
            memcpy(s->position[count], x, sizeof x);
            slot[at] = count++;
        }
        number[i] = slot[at];
    }
    for (int64_t i = 0; i < corner_count; ++i) {
        s->node[i] = number[s->node[i]];
    }
    s->joined_count = s->node_count - s->unused_count - count;
    s->node_count = count;
    free(slot);
    free(number);
    return true;
}

/* ---- writing ---- */

static bool write_surface(const surface *s, FILE *out)
{
    const size_t corner_count = (size_t)s->face_count * s->corners;
    ss_import_header header = {.node_count = s->node_count,
                               .triangle_count = s->corners == 3 ? s->face_count : 0,
                               .quad_count = s->corners == 4 ? s->face_count : 0,
                               .cut_face_count = s->cut_face_count,
                               .joined_count = s->joined_count,
                               .unused_count = s->unused_count};
    memcpy(header.magic, SS_IMPORT_MAGIC, sizeof header.magic);
    return fwrite(&header, sizeof header, 1, out) == 1 &&
           fwrite(s->position, sizeof *s->position, (size_t)s->node_count, out) ==
               (size_t)s->node_count &&
           fwrite(s->node, sizeof *s->node, corner_count, out) == corner_count && fflush(out) == 0;
}

/* `what` begins with ':' where it has a line number first. */
static int fail(const char *path, const char *what)
{
    ss_plain_print(stderr, SS_IMPORT_NAME "%s%s%s\n", path, what[0] == ':' ? "" : ": ", what);
    return 2;
}

/* Whose limit it was: the mesh is to blame for the importer's own alone. */
static const char *say_no_memory(void)
{
    static char text[128] = "too large for 1 GiB of memory: simplify the mesh first";
    const rlim_t least = memory_limit();
    if (least < (rlim_t)SS_IMPORT_MAX_BYTES) {
        (void)snprintf(text, sizeof text,
                       "it does not fit into the %llu MiB of memory that are allowed here (ulimit "
                       "-v): allow more",
                       (unsigned long long)least >> 20);
    }
    return text;
}

/* What assimp says of a file that it cannot read. Of memory it names the exception, if anything:
 * the mesh is not to blame. */
static const char *assimp_problem(void)
{
    static char text[600];
    const char *said = aiGetErrorString();
    if (said[0] == '\0' || strstr(said, "bad_alloc") != NULL) {
        return say_no_memory();
    }
    (void)snprintf(text, sizeof text, "%.500s: correct it, or write the mesh again as OBJ", said);
    return text;
}

/* NULL when good, else what is wrong and what to do. */
static const char *read_surface(const char *path, surface *s)
{
    obj_text prepared = {0}; /* of a PLY the text alone */
    const obj_text *obj = has_ending(path, ".obj") ? &prepared : NULL;
    const char *problem = obj != NULL                ? obj_prepare(path, &prepared)
                          : has_ending(path, ".stl") ? stl_check(path)
                          : has_ending(path, ".ply")
                              ? ply_prepare(path, &prepared.text, &prepared.size)
                              : NULL;
    if (problem != NULL) {
        return problem == beside_no_memory ? say_no_memory() : problem;
    }
    static beside_files files;
    beside_init(&files, path, prepared.text, prepared.size);
    const struct aiScene *scene = read_scene(&files, obj, s, &problem);
    if (scene == NULL && files.refused[0] != '\0') {
        return files.refused;
    }
    if (scene == NULL) {
        return problem != NULL ? problem : assimp_problem();
    }
    if (!allocate(s, scene, obj)) {
        return say_no_memory();
    }
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        if (!add_mesh(s, scene->mMeshes[m], obj)) {
            return "a face has vertices that do not exist: write the mesh again as OBJ";
        }
    }
    if (s->face_count == 0) {
        return "no triangles in it: give a surface mesh";
    }
    if (!join_nodes(s)) {
        return say_no_memory();
    }
    if (obj == NULL) {
        /* Other formats repeat a vertex for every face, or for every normal: that is no fault. */
        s->joined_count = 0;
        s->unused_count = 0;
    }
    return NULL;
}

static int convert(const char *path)
{
    if (isatty(STDOUT_FILENO)) {
        return fail(path, "the answer is binary data: use softsim-mesh info FILE");
    }
    set_limits();

    /* assimp must not print into the answer. */
    const int fd = dup(STDOUT_FILENO);
    FILE *out = fd >= 0 && dup2(STDERR_FILENO, STDOUT_FILENO) >= 0 ? fdopen(fd, "wb") : NULL;
    surface s = {0};
    const char *problem = out != NULL ? read_surface(path, &s) : "cannot write to stdout";
    if (problem == NULL && !write_surface(&s, out)) {
        problem = "cannot write to stdout";
    }
    return problem != NULL ? fail(path, problem) : 0;
}

int main(int argc, char **argv)
{
    ss_program_begin();
    if (argc == 2 && strcmp(argv[1], "--version") == 0) {
        (void)printf("softsim-import %s\n", SOFTSIM_VERSION);
        return ss_program_finish(argv[0], 0);
    }
    if (argc != 2 || strcmp(argv[1], "--help") == 0) {
        const bool is_asked = argc == 2;
        (void)fprintf(is_asked ? stdout : stderr,
                      "usage: softsim-import FILE\n"
                      "Reads the surface in an OBJ, STL, PLY, GLB or glTF file and writes it in a "
                      "binary form to stdout, for the other programs of softsim.\n");
        return ss_program_finish(argv[0], is_asked ? 0 : 2);
    }
    ss_program_begin_setup(); /* assimp zeroes 32 MB for an OBJ of any size */
    /* At once: what is left of the scene, and assimp's own exit code, are of no use to anyone. */
    _exit(convert(argv[1]));
}
