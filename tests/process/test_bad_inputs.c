/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
/*
 * Bad input: scenes, meshes, logs, arguments. Each gets one clear error with a word that names
 * the fault, exit 2, and nothing is started. Prints the table of what each got.
 */
#include "common/test.h"

#include <glob.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/effort.h"
#include "process.h"

#define SCENES   SOURCE_DIR "/server/scenes/"
#define KIDNEY   SCENES "kidney.yaml"
#define CYLINDER SCENES "cylinder.yaml"

#include "common/folder_fixture.h"

static void check(process *p, const char *what, const char *const *argv, const char *word)
{
    process_start(p, argv, NULL);
    const int status = process_finish(p);
    char first[160];
    snprintf(first, sizeof first, "%.*s", (int)strcspn(p->err, "\n"), p->err);
    print_message("%-44s exit %d  %s\n", what, status, first);
    if (status != 2 || !strstr(p->err, word) || strstr(p->out, "ready")) {
        fail_msg("%s: exit %d, wanted 2 with '%s' in: %s%s", what, status, word, p->out, p->err);
    }
}

/* ---- scenes and meshes ---- */

typedef struct scene_case {
    const char *what, *mesh_name, *mesh, *body, *word;
} scene_case;

/* A tetrahedron's surface; %-cases change one thing. */
#define GOOD_MESH "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
#define FAR_MESH                                                                                   \
    "v 200000 0 0\nv 200010 0 0\nv 200000 10 0\nv 200000 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 "  \
    "4\n"
#define OBJECT(name)                                                                               \
    "softsim: 1\nobject: {mesh: " name ", units: mm, fixed: [{nodes: [0, 1, 2]}]}\n"
#define MODEL "model: {name: cnn-energy, modulus_j: 1}\n"

#define BODY                                                                                       \
    "area_density_kg_m2: 11.5, damping_n_s_per_m3: 1725, rest_stiffness_n_per_m3: 5.0e+4}\n"

static const scene_case scene_cases[] = {
    {"scene: empty", NULL, NULL, "", "yaml"},
    {"scene: not YAML", NULL, NULL, "softsim: [1\nobject: }{", "yaml"},
    {"scene: a list", NULL, NULL, "- 1\n- 2\n", "yaml"},
    {"scene: binary", NULL, NULL, "\x01\x02\xff\xfe", "yaml"},
    {"scene: wrong version", "m.obj", GOOD_MESH,
     "softsim: 7\nobject: {mesh: m.obj, units: mm}\n" MODEL, "softsim"},
    {"scene: unknown key", "m.obj", GOOD_MESH, OBJECT("m.obj") MODEL "gravty_m_s2: [0, 0, 0]\n",
     "gravity_m_s2"},
    {"scene: no units", "m.obj", GOOD_MESH, "softsim: 1\nobject: {mesh: m.obj}\n" MODEL, "units"},
    {"scene: unknown units", "m.obj", GOOD_MESH,
     "softsim: 1\nobject: {mesh: m.obj, units: furlong}\n" MODEL, "furlong"},
    {"scene: no model", "m.obj", GOOD_MESH, OBJECT("m.obj"), "model"},
    {"scene: unknown model", "m.obj", GOOD_MESH, OBJECT("m.obj") "model: {name: jelly}\n", "jelly"},
    {"scene: unknown parameter", "m.obj", GOOD_MESH,
     OBJECT("m.obj") "model: {name: cnn-energy, modulus_j: 1, springs: 3}\n", "springs"},
    {"scene: negative modulus", "m.obj", GOOD_MESH,
     OBJECT("m.obj") "model: {name: cnn-energy, modulus_j: -1}\n", "modulus_j"},
    {"scene: text for a number", "m.obj", GOOD_MESH,
     OBJECT("m.obj") "model: {name: cnn-energy, modulus_j: much}\n", "modulus_j"},
    {"scene: not a number", "m.obj", GOOD_MESH,
     OBJECT("m.obj") "model: {name: cnn-energy, modulus_j: .nan}\n", "modulus_j"},
    {"scene: probe 9", "m.obj", GOOD_MESH,
     OBJECT("m.obj") MODEL "contact: {tools: [{probe: 9, shape: {sphere: {radius_mm: 5}}}]}\n",
     "probe"},
    {"scene: one probe twice", "m.obj", GOOD_MESH,
     OBJECT("m.obj") MODEL "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 5}}}, {probe: "
                           "0, shape: {sphere: {radius_mm: 5}}}]}\n",
     "probe"},
    {"scene: sphere of radius 0", "m.obj", GOOD_MESH,
     OBJECT("m.obj") MODEL "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 0}}}]}\n",
     "radius_mm"},
    {"scene: unknown shape", "m.obj", GOOD_MESH,
     OBJECT("m.obj") MODEL "contact: {tools: [{probe: 0, shape: {torus: {radius_mm: 5}}}]}\n",
     "torus"},
    {"scene: haptic rate 0", "m.obj", GOOD_MESH, OBJECT("m.obj") MODEL "haptic: {rate_hz: 0}\n",
     "rate_hz"},
    {"scene: fixed node out of range", "m.obj", GOOD_MESH,
     "softsim: 1\nobject: {mesh: m.obj, units: mm, fixed: [{nodes: [0, 1, 77]}]}\n" MODEL, "77"},
    {"scene: fixed box without nodes", "m.obj", GOOD_MESH,
     "softsim: 1\nobject: {mesh: m.obj, units: mm, fixed: [{box_m: [[5, 5, 5], [6, 6, "
     "6]]}]}\n" MODEL,
     "box_m"},
    {"scene: group that the mesh has not", "m.obj", GOOD_MESH,
     "softsim: 1\nobject: {mesh: m.obj, units: mm, fixed: [{group: base}]}\n" MODEL, "base"},
    {"scene: a tool too small for the mesh", "m.obj", GOOD_MESH,
     OBJECT("m.obj") "model: {name: cnn-energy, modulus_j: 1, " BODY
                     "contact: {tools: [{probe: 0, shape: {sphere: {radius_mm: 0.01}}}]}\n",
     "scene.yaml: model: the smallest of contact.tools"},
    {"scene: pretension of a loose body", "m.obj", GOOD_MESH,
     "softsim: 1\nobject: {mesh: m.obj, units: mm}\n"
     "model: {name: cnn-energy, modulus_j: 1, pretension_j: 1, " BODY,
     "scene.yaml: model: cnn-energy: each separate part is to have three fixed nodes"},
    {"mesh: missing", NULL, NULL, OBJECT("nowhere.obj") MODEL, "nowhere.obj"},
    {"mesh: empty", "m.obj", "", OBJECT("m.obj") MODEL, "m.obj"},
    {"mesh: binary", "m.stl", "\x7f\x45\x4c\x46\x01\x02\x03", OBJECT("m.stl") MODEL, "m.stl"},
    {"mesh: unknown kind", "m.xyz", "hello", OBJECT("m.xyz") MODEL, "m.xyz"},
    {"mesh: index out of range", "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
     OBJECT("m.obj") MODEL, "m.obj"},
    {"mesh: not a number", "m.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\n",
     OBJECT("m.obj") MODEL, "m.obj"},
    {"mesh: coincident nodes", "m.msh",
     "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 10 0 0\n3 0 10 0\n4 0 10 "
     "0\n$EndNodes\n$Elements\n2\n1 2 0 1 2 3\n2 2 0 1 4 2\n$EndElements\n",
     OBJECT("m.msh") MODEL, "m.msh"},
    {"mesh: edge with three triangles", "m.msh",
     "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 10 0 0\n3 0 10 0\n4 0 0 10\n5 0 "
     "-9 0\n$EndNodes\n$Elements\n3\n1 2 0 1 2 3\n2 2 0 2 1 4\n3 2 0 1 2 5\n$EndElements\n",
     OBJECT("m.msh") MODEL, "more than two triangles"},
    {"mesh: MSH cut short", "m.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n400\n1 0 0 0\n",
     OBJECT("m.msh") MODEL, "m.msh"},
    {"mesh: MSH with a huge count", "m.msh",
     "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n99999999999\n1 0 0 0\n", OBJECT("m.msh") MODEL,
     "m.msh"},
};

TEST(scenes_and_meshes_are_refused)
{
    static process p;
    for (size_t i = 0; i < sizeof scene_cases / sizeof *scene_cases; ++i) {
        const scene_case *c = &scene_cases[i];
        if (c->mesh) {
            write_bytes(c->mesh_name, c->mesh, strlen(c->mesh));
        }
        write_bytes("scene.yaml", c->body, strlen(c->body));
        const char *const argv[] = {"softsimd", in_folder("scene.yaml"), NULL};
        check(&p, c->what, argv, c->word);
        if (c->mesh) {
            unlink(in_folder(c->mesh_name));
        }
    }
}

/* ---- scenes that are valid, and doubtful ---- */

TEST(checks_tell_what_is_good_and_what_is_doubtful)
{
    static process p;
    static const struct {
        const char *mesh, *units, *radius_mm, *doubt; /* NULL: none */
    } cases[] = {
        {GOOD_MESH, "mm", "14", NULL},
        {GOOD_MESH, "mm", "9", "object.mesh: what is felt is a smooth surface through the mesh"},
        {GOOD_MESH, "mm", "5", "tool 3 is small beside the mesh"},
        {GOOD_MESH, "m", "5000", "object.units: the body's diagonal is 17.3"},
        {GOOD_MESH, "um", "0.005", "object.units: the body's diagonal is 1.7"},
        {GOOD_MESH, "mm", "5000",
         "contact.tools, probe 3, sphere.radius_mm: the tool (radius 5000 mm)"},
        {FAR_MESH, "mm", "14", "object.mesh: the body is up to 200 m from the origin"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char scene[1024];
        snprintf(scene, sizeof scene,
                 "softsim: 1\nobject: {mesh: m.obj, units: %s, fixed: [{nodes: [0, 1, 2]}]}\n"
                 "model: {name: cnn-energy, modulus_j: 1, " BODY
                 "contact: {tools: [{probe: 3, shape: {sphere: {radius_mm: %s}}}]}\n",
                 cases[i].units, cases[i].radius_mm);
        write_bytes("m.obj", cases[i].mesh, strlen(cases[i].mesh));
        write_bytes("scene.yaml", scene, strlen(scene));
        const char *const argv[] = {"softsimd", "--check", in_folder("scene.yaml"), NULL};
        assert_int_equal(process_run(&p, argv), cases[i].doubt ? 1 : 0);
        print_message("%s", p.err);
        assert_non_null(strstr(p.err, cases[i].doubt ? "scene.yaml: usable, with "
                                                     : "scene.yaml: good (4 nodes"));
        assert_non_null(strstr(p.err, " (4 nodes, 4 triangles, cnn-energy, 1 tool)\n"));
        assert_true((strstr(p.err, "warning") != NULL) == (cases[i].doubt != NULL));
        if (cases[i].doubt && !strstr(p.err, cases[i].doubt)) {
            fail_msg("no '%s' in: %s", cases[i].doubt, p.err);
        }
        assert_int_equal(p.out_size, 0);
    }
}

/* The last line that a program said. */
static const char *last_line(const process *p)
{
    const char *last = p->err;
    for (const char *at = p->err; (at = strchr(at, '\n')) != NULL && at[1] != '\0';) {
        last = ++at;
    }
    return last;
}

/* What the author of a scene asks first. The kidney's box is its generator's: 110 x 59 x 45 mm. */
TEST(a_check_tells_what_a_new_scene_is_and_what_to_do_next)
{
    static process p;
    static const char *const says[] = {"kidney.yaml: box: -0.05", ": 110 x 58.6 x 45.2 mm\n",
                                       "kidney.yaml: fixed: 64 of 1200 nodes\n",
                                       "kidney.yaml: cost: about ",
                                       "from +z: softsim-bridge --device sim --offset-m 0."};
    static const struct {
        const char *set;
        int status;
        const char *says, *next;
    } cases[] = {
        {"model.rho=[{where: {sphere: {center_m: [0, 0, 0], radius_m: 1}}, value: 1}, {where: "
         "{nodes: "
         "[5]}, value: 2}]",
         1, "warning: " SCENES "kidney.yaml: model.rho.1: no node has this value",
         "heed the warnings"},
        {"model.rho=[{where: {nodes: [4, 5]}, value: 1}, {where: {nodes: [5, 6, 7]}, value: 2}, "
         "{value: "
         "3}]",
         0, "model.rho.1: 1 of its 3 nodes have the value of an earlier entry", "softsimd " SCENES},
        {"contact.tools=[]", 0, "kidney.yaml: good", "add a tool under contact.tools"},
        {"model.nonsense=1", 2, "nonsense", "mend what is named above"},
    };
    const char *const check[] = {"softsimd", "--check", SCENES "kidney.yaml", NULL};
    assert_int_equal(process_run(&p, check), 0);
    for (size_t i = 0; i < sizeof says / sizeof *says; ++i) {
        if (!strstr(p.err, says[i])) {
            fail_msg("no '%s' in: %s", says[i], p.err);
        }
    }
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const char *const argv[] = {"softsimd", "--check",    SCENES "kidney.yaml",
                                    "--set",    cases[i].set, NULL};
        if (process_run(&p, argv) != cases[i].status || !strstr(p.err, cases[i].says) ||
            strncmp(last_line(&p), "softsimd: next: ", 16) != 0 ||
            !strstr(last_line(&p), cases[i].next)) {
            fail_msg("%s: %d: %s", cases[i].set, p.status, p.err);
        }
    }
}

/* ---- the bundled scenes ---- */

TEST(what_a_bundled_scene_prints_loads_again)
{
    SKIP_WHERE_REPEATED();
    static process p;
    static char printed[sizeof p.out];
    glob_t scene;
    assert_int_equal(glob(SCENES "*.yaml", 0, NULL, &scene), 0);
    assert_true(scene.gl_pathc > 5);
    for (size_t i = 0; i < scene.gl_pathc; ++i) {
        const char *const print[] = {"softsimd", "--print-config", scene.gl_pathv[i], NULL};
        const int status = process_run(&p, print);
        if (status == 2 && strstr(p.err, "not built in")) {
            continue;
        }
        const size_t size = (size_t)p.out_size;
        assert_in_range(size, 100, sizeof printed - 1);
        memcpy(printed, p.out, size);
        write_bytes("scene.yaml", printed, size);
        const char *const again[] = {"softsimd", "--print-config", in_folder("scene.yaml"), NULL};
        if (status != 0 || process_run(&p, again) != 0) {
            fail_msg("%s: %s", scene.gl_pathv[i], p.err);
        }
        assert_int_equal(p.out_size, size);
        assert_memory_equal(p.out, printed, size);
    }
    globfree(&scene);
}

/* ---- arguments ---- */

TEST(arguments_are_refused)
{
    static process p;
    const struct {
        const char *what, *argv[8], *word;
    } cases[] = {
        {"softsimd: no scene", {"softsimd"}, "SCENE.yaml"},
        {"softsimd: unknown option", {"softsimd", KIDNEY, "--fast"}, "--fast"},
        {"softsimd: missing scene", {"softsimd", "/nowhere/x.yaml"}, "/nowhere/x.yaml"},
        {"softsimd: a folder for a scene", {"softsimd", "/tmp"}, "/tmp"},
        {"softsimd: two scenes", {"softsimd", KIDNEY, KIDNEY}, "too many"},
        {"softsimd: --duration abc", {"softsimd", KIDNEY, "--duration", "abc"}, "--duration"},
        {"softsimd: --threads 0", {"softsimd", KIDNEY, "--threads", "0"}, "--threads"},
        {"softsimd: --realtime maybe", {"softsimd", KIDNEY, "--realtime", "maybe"}, "--realtime"},
        {"softsimd: --set of no key", {"softsimd", KIDNEY, "--set", "haptic.maximum=3"}, "maximum"},
        {"softsimd: --set without a value",
         {"softsimd", KIDNEY, "--set", "haptic.max_force_n"},
         "max_force_n"},
        {"softsimd: --set out of range",
         {"softsimd", KIDNEY, "--set", "haptic.max_force_n=-1"},
         "max_force_n"},
        {"softsimd: bad prefix", {"softsimd", CYLINDER, "--prefix", "a b"}, "prefix"},
        {"softsimd: bad LCM url", {"softsimd", CYLINDER, "--lcm-url", "tcpq://"}, "tcpq://"},
        {"softsimd: a ttl of -1",
         {"softsimd", CYLINDER, "--lcm-url", "udpm://239.255.76.67:7667?ttl=-1"},
         "ttl=-1"},
        {"softsimd: a ttl beyond all",
         {"softsimd", CYLINDER, "--lcm-url", "udpm://239.255.76.67:7667?ttl=999999999999"},
         "ttl=999999999999"},
        {"softsimd: commands and none",
         {"softsimd", CYLINDER, "--allow-commands", "--no-commands"},
         "give one of them"},
        {"softsim-monitor: a ttl of -1",
         {"softsim-monitor", "--lcm-url", "udpm://239.255.76.67:7667?ttl=-1"},
         "ttl=-1"},
        {"softsim-run: nothing says when to end", {"softsim-run", KIDNEY}, "--duration"},
        {"softsim-run: --dt with a log",
         {"softsim-run", KIDNEY, "--poses", SCENES "kidney-poke.lcmlog", "--dt", "0.001"},
         "--dt"},
        {"softsim-run: missing poses",
         {"softsim-run", KIDNEY, "--poses", "/nowhere/p.csv"},
         "/nowhere/p.csv"},
        {"softsim-replay: no log", {"softsim-replay"}, "LOG"},
        {"softsim-replay: missing log",
         {"softsim-replay", "/nowhere/p.lcmlog"},
         "/nowhere/p.lcmlog"},
        {"softsim-replay: --speed 0",
         {"softsim-replay", SCENES "kidney-poke.lcmlog", "--speed", "0"},
         "--speed"},
        {"softsim-bridge: no device", {"softsim-bridge"}, "--device"},
        {"softsim-bridge: unknown device", {"softsim-bridge", "--device", "wand"}, "wand"},
        {"softsim-bridge: bad axes",
         {"softsim-bridge", "--device", "sim", "--axes", "x,x,z"},
         "--axes"},
        {"softsim-monitor: unknown option", {"softsim-monitor", "--twice"}, "--twice"},
        {"softsim-bench: missing poses",
         {"softsim-bench", "latency", "--poses", "/nowhere/p.lcmlog"},
         "/nowhere/p.lcmlog"},
        {"softsim-bench: missing scene",
         {"softsim-bench", "latency", "--scene", "/nowhere/s.yaml"},
         "/nowhere/s.yaml"},
        {"softsim-mesh: unknown verb", {"softsim-mesh", "knead"}, "knead"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        check(&p, cases[i].what, cases[i].argv, cases[i].word);
        const char *end =
            strchr(p.err, '\n'); /* one fault, one line; cases of scenes quote theirs */
        if (!strstr(p.err, "^") && end && end[1] != '\0') {
            fail_msg("%s: more than the fault itself: %s", cases[i].what, p.err);
        }
    }
}

/* ---- pose files ---- */

TEST(poses_are_refused)
{
    static process p;
    const struct {
        const char *what, *text, *word;
    } cases[] = {
        {"poses: empty", "", "poses"},
        {"poses: wrong header", "t,x,y,z\n0,1,2,3\n", "poses"},
        {"poses: too few columns", "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,1,2\n", "2"},
        {"poses: not a number", "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,nan,0,0,1,0,0,0,0\n",
         "2"},
        {"poses: no unit quaternion",
         "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n0,0,0,0,0,1,1,0,0,0\n", "2"},
        {"poses: time goes back",
         "time_s,probe,x,y,z,qw,qx,qy,qz,buttons\n1,0,0,0,0,1,0,0,0,0\n0,0,0,0,0,1,0,0,0,0\n", "3"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        write_bytes("poses.csv", cases[i].text, strlen(cases[i].text));
        const char *const argv[] = {"softsim-run", KIDNEY, "--poses", in_folder("poses.csv"), NULL};
        check(&p, cases[i].what, argv, cases[i].word);
    }
}

/* ---- damaged logs: read up to the damage and beyond, reported ---- */

static unsigned char *read_whole(const char *path, size_t *out_size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *out_size = (size_t)ftell(file);
    rewind(file);
    unsigned char *data = malloc(*out_size);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *out_size, file), *out_size);
    fclose(file);
    return data;
}

static void put_length(unsigned char *at, uint32_t value)
{
    for (int i = 0; i < 4; ++i) {
        at[i] = (unsigned char)(value >> (24 - 8 * i));
    }
}

/* A run of what is left is none of the log's, but where only the last record is cut. */
TEST(damaged_logs_are_read_up_to_the_damage)
{
    static process p;
    size_t size = 0;
    unsigned char *log = read_whole(SCENES "kidney-poke.lcmlog", &size);
    const uint32_t channel_length =
        (uint32_t)log[20] << 24 | (uint32_t)log[21] << 16 | (uint32_t)log[22] << 8 | log[23];
    const uint32_t data_length =
        (uint32_t)log[24] << 24 | (uint32_t)log[25] << 16 | (uint32_t)log[26] << 8 | log[27];
    const size_t record = 28 + channel_length + data_length;
    unsigned char *at = log + 50 * record; /* damage record 50 */
    unsigned char kept[28];
    memcpy(kept, at, sizeof kept);
    const struct {
        const char *what;
        int kind;
    } cases[] = {{"log: truncated tail", 0},
                 {"log: bad magic", 1},
                 {"log: data length 0x7ffffffe", 2},
                 {"log: data length 0x7fffffff", 3},
                 {"log: channel length 0x7fffffff", 4},
                 {"log: negative length", 5}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        size_t written = 100 * record;
        switch (cases[i].kind) {
        case 0:
            written = 99 * record + record / 2;
            break;
        case 1:
            at[0] ^= 0xff;
            break;
        case 2:
            put_length(at + 24, 0x7ffffffeu);
            break;
        case 3:
            put_length(at + 24, 0x7fffffffu);
            break;
        case 4:
            put_length(at + 20, 0x7fffffffu);
            break;
        default:
            put_length(at + 24, 0xfffffff0u);
            break;
        }
        write_bytes("damaged.lcmlog", log, written);
        memcpy(at, kept, sizeof kept);
        const char *const csv = in_folder("out.csv");
        const char *const argv[] = {"softsim-run", KIDNEY, "--poses", in_folder("damaged.lcmlog"),
                                    "--csv",       csv,    NULL};
        assert_int_equal(process_run(&p, argv), cases[i].kind == 0 ? 0 : 1);
        assert_int_equal(access(csv, F_OK), cases[i].kind == 0 ? 0 : -1);
        assert_int_equal(unlink(in_folder("out.csv.part")), cases[i].kind == 0 ? -1 : 0);
        unlink(csv);
        char first[160];
        snprintf(first, sizeof first, "%.*s", (int)strcspn(p.err, "\n"), p.err);
        print_message("%-44s exit %d  %s\n", cases[i].what, p.status, first);
        assert_non_null(strstr(p.err, "byte"));
        assert_non_null(
            strstr(p.err, cases[i].kind == 0 ? " 99 ticks" : " 9")); /* the rest is read */
    }
    free(log);
}

/* ---- names ---- */

/* Control characters, of one byte and of two, and a line of another's making. */
#define HOSTILE                                                                                    \
    "n\x1b[31m\x9b"                                                                                \
    "2J\xc2\x9bK\nforged"

static void expect_harmless(const process *p, const char *what)
{
    const char *const text[] = {p->out, p->err};
    assert_true(p->out_size + p->err_size > 0);
    for (int t = 0; t < 2; ++t) {
        if (strstr(text[t], "\nforged")) {
            fail_msg("%s: a name forged a line: %s", what, text[t]);
        }
        for (const unsigned char *at = (const unsigned char *)text[t]; *at != '\0'; ++at) {
            if ((*at < ' ' && *at != '\n') || *at >= 0x7f) { /* the name alone is not ASCII */
                fail_msg("%s: byte 0x%02x in: %s", what, *at, text[t]);
            }
        }
    }
}

TEST(no_name_drives_a_terminal)
{
    char mesh[256], scene[256], none[256];
    snprintf(mesh, sizeof mesh, "%s", write_text(HOSTILE ".obj", GOOD_MESH));
    snprintf(scene, sizeof scene, "%s",
             write_text(HOSTILE ".yaml", "softsim: 1\nobject: {mesh: m.obj, units: mm, fixed: "
                                         "[{nodes: [0, 1, 2]}]}\nmodel: {name: cnn-energy, "
                                         "modulus_j: 1, rho: 1, " BODY));
    write_text("m.obj", GOOD_MESH);
    snprintf(none, sizeof none, "%s", in_folder(HOSTILE ".none"));
    const char *const runs[][6] = {
        {"softsimd", scene, "--check"},
        {"softsimd", scene, "--explain"},
        {"softsimd", scene, "--print-config"},
        {"softsimd", scene, "--set", HOSTILE "=1"},
        {"softsimd", none},
        {"softsimd", mesh},
        {"softsimd", scene, "--prefix", HOSTILE},
        {"softsimd", scene, "--lcm-url", HOSTILE},
        {"softsimd", HOSTILE "1", HOSTILE "2"},
        {"softsim-run", scene, "--duration", "0.01"},
        {"softsim-run", scene, "--poses", mesh},
        {"softsim-run", scene, "--poses", none},
        {"softsim-mesh", "info", mesh},
        {"softsim-mesh", "check", mesh},
        {"softsim-mesh", "check", mesh, "--json"},
        {"softsim-mesh", "convert", mesh, in_folder(HOSTILE ".msh")},
        {"softsim-mesh", "convert", mesh, none},
        {"softsim-mesh", HOSTILE},
        {"softsim-mesh", "info", scene},
        {"softsim-replay", mesh},
        {"softsim-replay", none},
        {"softsim-bridge", "--device", HOSTILE},
    };
    for (size_t r = 0; r < sizeof runs / sizeof *runs; ++r) {
        process p = {0};
        process_run(&p, runs[r]);
        char what[64];
        snprintf(what, sizeof what, "%s, run %zu", runs[r][0], r);
        expect_harmless(&p, what);
    }
}

int main(void)
{
    return run_all_tests(make_folder, remove_folder);
}
