/* test_io.c: examples/lib/pbw_io.h and examples/lib/pbw_picture.h: numbers, every reader on good and on broken files,
   every writer read back, full disks, memory that runs out; and the program pbw, if it lies beside this one. */
#define _GNU_SOURCE
#include <dirent.h>
#include <fcntl.h>
#include <locale.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static size_t held, peak, most_held, fail_at, requests, wrong_sizes;
static int once;                                     /* refuses request number fail_at only, else also all after it */

/* Counts what is held, peak with both sizes while a block is resized; compares what it is told of old sizes. */
static void *count_resize(void *user, void *ptr, size_t old_size, size_t new_size)
{
    size_t *old = ptr == NULL ? NULL : (size_t *)ptr - 2, *block = NULL;
    (void)user;
    wrong_sizes += old_size != (old == NULL ? 0 : old[0]);
    if (new_size != 0) {
        requests++;
        if (fail_at != 0 && (once ? requests == fail_at : requests >= fail_at)) {
            return NULL;
        }
        block = (size_t *)malloc(new_size + 2 * sizeof(size_t));
        held += new_size;
        peak = held > peak ? held : peak;
        block[0] = new_size;
    }
    if (old != NULL) {
        if (block != NULL) {
            memcpy(block + 2, ptr, old[0] < new_size ? old[0] : new_size);
        }
        held -= old[0];
        free(old);
    }
    most_held = held > most_held ? held : most_held;
    return block == NULL ? NULL : block + 2;
}

#include "../pbw.h"
#define PBW_IO_IMPLEMENTATION
#include "../examples/lib/pbw_io.h"
#define PBW_PICTURE_IMPLEMENTATION
#include "../examples/lib/pbw_picture.h"
#define PBW_MODEL_IMPLEMENTATION
#include "../examples/lib/pbw_model.h"
#include "io_samples.h"
#include "test.h"

static pbw_options counted;                          /* with count_resize */
static pbwio_options plain;                          /* with it */

static pbwio_output counted_output(void)
{
    pbwio_output output;
    memset(&output, 0, sizeof output);
    output.build = &counted;
    return output;
}

static char folder[64], program[256];

static uint64_t next_random(void)
{
    static uint64_t state;
    state = state == 0 ? test_seed * 0x9e3779b97f4a7c15u + 1 : state;
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

static double unit_random(void)
{
    return (double)(next_random() >> 11) * 0x1p-53;
}

/* ---- numbers ---- */

static int reads_as(const char *text, double expected)
{
    double value = 0;
    return pbwio__number(text, text + strlen(text), &value) && memcmp(&value, &expected, sizeof value) == 0;
}

static void test_numbers(void)
{
    static const char *const good[] = {
        "0", "-0", "+1", "1.", ".5", "-.5e1", "1e22", "1e23", "9007199254740993", "9007199254740992.5",
        "123456789012345678", "0.1", "2.2250738585072011e-308", "2.2250738585072012e-308", "4.9406564584124654e-324",
        "2.4703282292062327e-324", "2.4703282292062328e-324", "1.7976931348623157e308", "1.7976931348623158e308",
        "1e-400", "-1e-99999999999999999999", "0e99999999999999999999", "1e+5", "8.5E-3",
        "0.000000000000000000000000000000000000000000001e45",
        "17976931348623157000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000"
    };
    static const char *const bad[] = {
        "", "-", "+", ".", "e5", "1e", "1e+", "1.2.3", "1,5", "0x10", "nan", "inf", "-inf", "1e309", "1.8e308", "1 2",
        "--1", "1e5.0", "1f", "\xc2\xa0 1"
    };
    char text[64], *longer = (char *)malloc(5000);
    double value;
    size_t i, k;
    for (i = 0; i < sizeof good / sizeof *good; i++) {
        if (!CHECK(reads_as(good[i], strtod(good[i], NULL)))) {
            test_say("%s", good[i]);
        }
    }
    for (i = 0; i < sizeof bad / sizeof *bad; i++) {
        if (!CHECK(!pbwio__number(bad[i], bad[i] + strlen(bad[i]), &value))) {
            test_say("%s", bad[i]);
        }
    }
    CHECK(reads_as("1d3", 1000) && reads_as("1D-3", 0.001));
    /* half-way between two doubles, then a one thousands of digits later */
    memset(longer, '0', 5000);
    memcpy(longer, "9007199254740993.", 17);
    longer[4998] = 0;
    CHECK(reads_as(longer, 9007199254740992.0));
    longer[4997] = '1';
    CHECK(reads_as(longer, 9007199254740994.0));
    memset(longer, '7', 4990);
    strcpy(longer + 4990, "e-4980");
    CHECK(reads_as(longer, strtod(longer, NULL)));
    free(longer);
    for (i = 0; i < 200000; i++) {                    /* any bits, written and read; and decimals against strtod */
        uint64_t bits = next_random();
        memcpy(&value, &bits, sizeof value);
        if (pbwio__finite(value)) {
            text[pbwio__print_number(text, value, 40)] = 0;
            CHECK(reads_as(text, value));
            snprintf(text, sizeof text, "%.*e", (int)(bits % 22), value);
            CHECK(!pbwio__finite(strtod(text, NULL)) || reads_as(text, strtod(text, NULL)));
        }
        k = (size_t)(next_random() % 25);
        snprintf(text, sizeof text, "%llu.%0*llue%d", (unsigned long long)(bits >> (bits & 63)), (int)k,
                 (unsigned long long)(bits % 1000000007u), (int)(bits % 61) - 30);
        CHECK(reads_as(text, strtod(text, NULL)));
    }
    text[pbwio__print_number(text, 0.1, 40)] = 0;
    CHECK(strcmp(text, "0.1") == 0);
    for (i = 0; i < 20000; i++) {                     /* in 20 characters: 13 digits, each rounded off in turn */
        uint64_t bits = next_random();
        double back = 0;
        memcpy(&value, &bits, sizeof value);
        value = i % 2 ? ldexp(0.5 - unit_random(), (int)(bits % 64) - 40) : value;
        if (pbwio__finite(value) && fabs(value) < 1e300) {
            int length = pbwio__print_number(text, value, 20);
            CHECK(length <= 20 && pbwio__number(text, text + length, &back));
            CHECK(fabs(back - value) <= 5.6e-13 * fabs(value));
        }
    }
}

/* ---- readers ---- */

typedef struct bad_file {
    const char *name, *text, *columns, *weight;
    int dim;
    const char *message;
} bad_file;

static const bad_file bad_files[] = {
    { "a.xyz", "", NULL, NULL, 0, "a.xyz: the file is empty" },
    { "a.xyz", "# only\n\n", NULL, NULL, 0, "a.xyz: the file has no points" },
    { "a.xyz", "x y z\n", NULL, NULL, 0, "a.xyz: the file has no points" },
    { "a.xyz", "1 2 3\n4 5\n", NULL, NULL, 0, "a.xyz:2: 2 columns where 3 are needed" },
    { "a.xyz", "1 2 3\n4 5 six\n", NULL, NULL, 0, "a.xyz:2: column 3, \"six\", is not a finite number" },
    { "a.xyz", "1 2 3\r\n\r\n4 nan 6\r\n", NULL, NULL, 0, "a.xyz:3: column 2, \"nan\", is not a finite number" },
    { "a.xyz", "1 2 3\n1e999 0 0", NULL, NULL, 0, "a.xyz:2: column 1, \"1e999\", is not a finite number" },
    { "a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nelement vertex 1\n"
      "property int x\nproperty int y\nend_header\n1 2\n1 2\n", NULL, NULL, 0,
      "a.ply:10: element \"vertex\" comes twice" },
    { "a.xyz", "5\n6\n", NULL, NULL, 0, "a.xyz:2: 1 coordinate where 2 are needed" },
    { "a.xyz", "1 2\n", NULL, NULL, 3, "a.xyz:1: 2 coordinates where 3 are needed" },
    { "a.xyz", "1 2 3\n", NULL, "4", 0, "a.xyz:1: column 4 is needed, there are 3" },
    { "a.xyz", "1 2 3\n", "1,9", NULL, 0, "a.xyz:1: column 9 is needed, there are 3" },
    { "a.xyz", "1 2 3\n", "1,,3", NULL, 0, "a.xyz: there is no column \"\": no line names the columns" },
    { "a.xyz", "1 2 3\n", "1", NULL, 0, "a.xyz:1: 1 coordinate where 2 are needed" },
    { "a.xyz", "1 2 3\n", NULL, NULL, 7, "a.xyz: dimension 7 is not 2 or 3" },
    { "a.csv", "1,2,3\n4,,6\n", NULL, NULL, 0, "a.csv:2: column 2, \"\", is not a finite number" },
    { "a.csv", "1,5;2,5\n", NULL, NULL, 0,
      "a.csv:1: column 1, \"1,5\", is not a finite number (decimal commas are read on request)" },
    { "a.csv", "x,y,z\n1,2,3\n", NULL, "mass", 0, "a.csv:1: there is no column \"mass\"; there are x, y, z" },
    { "a.csv", "east,north\n1,2\n", "east,up", NULL, 0, "a.csv:1: there is no column \"up\"; there are east, north" },
    { "a.txt", "1 2 3\r4 5 6\r", NULL, NULL, 0, "a.txt: lines end with CR alone: convert them to LF or CR LF" },
    { "a.txt", "\x1f\x8b\x08 and so on", NULL, NULL, 0, "a.txt: the compressed data are damaged" },
    { "a.txt", "PK\3\4 and so on", NULL, NULL, 0,
      "a.txt: the file is compressed, and not by gzip: unpack it first" },
    { "a.txt", "9 3\n1 2 3\n4 5 6\n", NULL, NULL, 0, "a.txt:1: 9 points are announced, 2 rows follow" },
    { "a.txt", "4 2 0\n0.5 0 0\n1 0 0\n0 1 0\n0 0 1\n", NULL, NULL, 0, "a.txt:1: this looks like a header of counts, "
      "4 rows follow: remove it, or write it with decimal points if it is a point" },
    { "a.txt", "4 1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n", NULL, NULL, 0,
      "a.txt:1: counts of points and faces: this looks like .off without its name" },
    { "a.xyz", "2\nwater\nO 0 0.0000000000 0\n", NULL, NULL, 0, "a.xyz:3: the file ends after 1 of 2 atoms" },
    { "a.xyz", "1\nframe 1\nO 0 0 0\n1\nframe 2\nO 0 0 1\n", NULL, NULL, 0,
      "a.xyz:4: more than 1 atoms: files of one frame are read" },
    { "a.json", "{\"a\": [1, 2}", NULL, NULL, 0, "a.json: byte 11: \"}\" closes nothing" },
    { "a.json", "[[1, 2], [3]]", "2,1", NULL, 3, "a.json: byte 0: 2 coordinates where 3 are needed" },
    { "a.json", "[[1, 2, 3], [3, 4]]", NULL, NULL, 0, "a.json: byte 17: 2 columns where 3 are needed" },
    { "a.json", "[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17]", NULL, NULL, 0,
      "a.json: byte 59: a list of many numbers: points are arrays of two or three" },
    { "a.json", "{\"x\": [1, 2", NULL, NULL, 0, "a.json: byte 11: the file ends inside brackets" },
    { "a.json", "{\"a\": 1}", NULL, NULL, 0,
      "a.json: byte 8: no points: arrays of numbers, or objects with x and y" },
    { "a.msh", "$MeshFormat\n1 0 8\n", NULL, NULL, 0, "a.msh:2: version 1: 2.2 and 4.1 are read" },
    { "a.msh", "$MeshFormat\n2.2 0 8\n$Nodes\n1\n7 0 0 0\n$EndNodes\n$Elements\n1\n1 2 0 7 7 8\n", NULL, NULL, 0,
      "a.msh:9: an element has a point that is not there, of 1" },
    { "a.msh", "$MeshFormat\n2.2 0 8\n$Nodes\n9\n7 0 0 0\n", NULL, NULL, 0,
      "a.msh:4: 9 points are announced, 8 bytes follow" },
    { "a.mesh", "MeshVersionFormatted 2\nDimension 4\nVertices 1\n0 0 0 0\n", NULL, NULL, 0,
      "a.mesh:3: vertices twice, or in 4 dimensions" },
    { "a.ele", "1 4 0\n0 0 1 2 3\n", NULL, NULL, 0,
      "a.ele: byte 0: the points of this file are in the .node file beside it" },
    { "a.txt", "\xff\xfe" "1", NULL, NULL, 0, "a.txt: the file is UTF-16 text: save it as UTF-8" },
    { "a.txt", "1 2 3\n\x1b[2J\x07 5 6\n", NULL, NULL, 0, "a.txt:2: column 1, \"?[2J?\", is not a finite number" },
    { "a.neigh", "1 2 3\n", NULL, NULL, 0, "a.neigh: this format is written, not read" },
    { "a.vtu", "1 2 3\n", NULL, NULL, 0, "a.vtu: byte 0: there are no points of three coordinates" },
    { "a.obj", "v 0 0 0\nv 1 0\n", NULL, NULL, 0, "a.obj:2: 2 columns where 3 are needed" },
    { "a.obj", "v 0 0 0\nf 1 1 2\n", NULL, NULL, 0, "a.obj:2: a face has point 2, there are 1" },
    { "a.obj", "v 0 0 0\nf -1 -1 -2\n", NULL, NULL, 0, "a.obj:2: a face has point -2, there are 1" },
    { "a.obj", "v 0 0 0\nf 1 0 1\n", NULL, NULL, 0, "a.obj:2: \"0\" is no corner of a face" },
    { "a.obj", "v 0 0 0\nf 1 x/2 1\n", NULL, NULL, 0, "a.obj:2: \"x/2\" is no corner of a face" },
    { "a.obj", "v 0 0 0\nf 1 1\n", NULL, NULL, 0, "a.obj:2: a face of 2 corners" },
    { "a.obj", "vn 0 0 1\nf 1 2 3\n", NULL, NULL, 0, "a.obj:2: a face has point 1, there are 0" },
    { "a.obj", "v 0 0 0\n", "1,name", NULL, 0, "a.obj: there is no column \"name\"; there are x, y, z" },
    { "a.off", "OFF\n", NULL, NULL, 0, "a.off:1: the line ends where the number of points should be" },
    { "a.off", "4OFF\n1 0 0\n", NULL, NULL, 0, "a.off:1: files of kind \"4OFF\" are not read" },
    { "a.off", "OFF BINARY\n1 0 0\n", NULL, NULL, 0, "a.off:1: binary OFF is not read" },
    { "a.off", "OFF\n3 1 0\n0.000 0 0\n1.000 0 0\n", NULL, NULL, 0, "a.off:4: the file ends after 2 of 3 points" },
    { "a.off", "OFF\n1 1 0\n0 0 0\n", NULL, NULL, 0, "a.off:3: the file ends after 0 of 1 faces" },
    { "a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n", NULL, NULL, 0, "a.off:4: a face has point 1, there are 1 (from 0)" },
    { "a.off", "OFF\n1 1 0\n0 0 0\n3 0 0\n", NULL, NULL, 0, "a.off:4: the line ends where the corner should be" },
    { "a.off", "OFF\n4000000000 1 0\n0 0 0\n", NULL, NULL, 0,
      "a.off:2: 4000000000 points are announced, 6 bytes follow" },
    { "a.off", "OFF\n-3 1 0\n", NULL, NULL, 0, "a.off:2: \"-3\" is not a number of points" },
    { "a.node", "2 3 0 0\n0 0 0 0\n2 1 1 1\n", NULL, NULL, 0, "a.node:3: point number 2 where 1 is due" },
    { "a.node", "1 4 0 0\n0 0 0 0 0\n", NULL, NULL, 0, "a.node:1: dimension 4, 0 attributes, 0 markers" },
    { "a.node", "2 3 0 0\n1 0.0000 0.0000 0\n", NULL, NULL, 0, "a.node:2: the file ends after 1 of 2 points" },
    { "a.node", "999999999999 3 0 0\n", NULL, NULL, 0,
      "a.node:1: 999999999999 points are announced, 0 bytes follow" },
    { "a.node", "1\n", NULL, NULL, 0, "a.node:1: the line ends where the dimension should be" },
    { "a.stl", "solid\nvertex 0 0 0\nvertex 0 0 0\nendloop\n", NULL, NULL, 0, "a.stl:4: a facet of 2 corners" },
    { "a.stl", "solid\nvertex 0 0 0\n", NULL, NULL, 0, "a.stl:2: the file ends inside a facet" },
    { "a.stl", "what\n", NULL, NULL, 0, "a.stl: the file has no points" },
    { "a.ply", "plyx\n", NULL, NULL, 0, "a.ply:1: the first line is not \"ply\"" },
    { "a.ply", "ply\nformat ascii 1.0\n", NULL, NULL, 0, "a.ply:2: the header has no end_header" },
    { "a.ply", "ply\nformat ebcdic 1.0\nend_header\n", NULL, NULL, 0, "a.ply:3: the header has no known format" },
    { "a.ply", "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nend_header\n1 2\n",
      NULL, NULL, 0, "a.ply:6: 9 points are announced, 4 bytes follow" },
    { "a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty text x\nend_header\n", NULL, NULL, 0,
      "a.ply:4: \"text\" is not a type" },
    { "a.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nend_header\n"
      "1 2\n1 two\n", NULL, NULL, 0, "a.ply:8: \"two\" is not a finite number" },
    { "a.ply", "ply\nformat ascii 1.0\nelement vertex many\nend_header\n", NULL, NULL, 0,
      "a.ply:3: \"many\" is not a number of elements" },
    { "a.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "end_header\n12345", NULL, NULL, 0, "a.ply: byte 98: 1 point is announced, 5 bytes follow" },
    { "a.ply", "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "end_header\n\x7f\xc0zzabcd", NULL, NULL, 0, "a.ply: byte 99: a value is not a finite number" },
    { "a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n1 2\n3 0 0 1\n", NULL, NULL, 0,
      "a.ply:10: a face has point 1, there are 1 (from 0)" },
    { "a.ply", "ply\nformat ascii 1.0\nwhatever\nend_header\n", NULL, NULL, 0,
      "a.ply:3: \"whatever\" is no header line" }
};

static void test_bad_files(void)
{
    size_t i;
    for (i = 0; i < sizeof bad_files / sizeof bad_files[0]; i++) {
        const bad_file *f = &bad_files[i];
        pbwio_options options = { PBWIO_AUTO, f->dim, f->columns, f->weight, NULL, 0, &counted };
        pbwio_cloud cloud;
        pbwio_error error;
        pbwio_status status = pbwio_read_memory(f->name, f->text, strlen(f->text), &options, &cloud, &error);
        CHECK(status != PBWIO_OK && cloud.count == 0 && cloud.points == NULL && held == 0);
        if (!CHECK(strcmp(error.text, f->message) == 0)) {
            test_say("is:     %s", error.text);
            test_say("should: %s", f->message);
        }
        CHECK(pbwio_read_memory(f->name, f->text, strlen(f->text), &options, &cloud, NULL) == status);
    }
}

static void check_sample(const io_sample *s, const char *name)
{
    pbwio_cloud cloud;
    pbwio_error error;
    double sum = 0;
    size_t i;
    error.text[0] = 0;
    peak = 0;
    if (!CHECK(pbwio_read_memory(name, s->data, s->size, &plain, &cloud, &error) == PBWIO_OK)) {
        test_say("%s: %s", s->name, error.text);
        return;
    }
    for (i = 0; i < cloud.count * (size_t)cloud.dim; i++) {
        sum += cloud.points[i];
    }
    if (!CHECK(cloud.dim == s->dim && cloud.count == s->points && cloud.triangle_count == s->triangles
               && sum <= s->sum && sum >= s->sum && peak <= io_bound(s->data, s->size))) {
        test_say("%s: %d, %zu, %zu, %g", s->name, cloud.dim, cloud.count, cloud.triangle_count, sum);
    }
    pbwio_free(&cloud);
    pbwio_free(&cloud);
    CHECK(held == 0 && cloud.count == 0);
}

static void test_samples(void)
{
    char buffer[1024], name[64];
    int i;
    for (i = 0; i < IO_SAMPLES; i++) {
        io_sample s = io_get_sample(i, buffer);
        check_sample(&s, s.name);
        if (strstr("bare.off zero.node one.node box.poly box.smesh", s.name) == NULL) {
            snprintf(name, sizeof name, "%d.unknown", i);            /* the content decides */
            check_sample(&s, name);
        }
    }
}

static void test_choices(void)
{
    static const char table[] = "id;Mass;north;east;up\n1;0.5;10;20;30\n2;0.25;11;21;31\n";
    static const char node[] = "2 2 2 1\n1 3 4 5 6 0\n2 7 8 9 10 1\n";
    char buffer[1024];
    io_sample ply = io_get_sample(IO_TEXT_SAMPLES + 1, buffer), obj = io_get_sample(7, buffer + 512);
    pbwio_options o = { PBWIO_AUTO, 0, "east,north", "mass", NULL, 0, &counted };
    pbwio_cloud c;
    CHECK(pbwio_read_memory("a.csv", table, sizeof table - 1, &o, &c, NULL) == PBWIO_OK);
    CHECK(c.dim == 2 && c.points[0] > 19 && c.points[1] < 11 && c.weights[1] < 0.3 && c.weights[0] > 0.4);
    pbwio_free(&c);
    o.columns = "4,3,5";
    o.weight = "2";
    CHECK(pbwio_read_memory("a.csv", table, sizeof table - 1, &o, &c, NULL) == PBWIO_OK);
    CHECK(c.dim == 3 && c.points[2] > 29 && c.points[5] > 30 && c.weights[0] > 0.4);
    pbwio_free(&c);
    o.columns = NULL;
    o.weight = "1";
    CHECK(pbwio_read_memory("a.csv", table, sizeof table - 1, &o, &c, NULL) == PBWIO_OK);
    CHECK(c.dim == 2 && c.points[0] > 19 && c.points[1] < 11 && c.weights[1] > 1);
    pbwio_free(&c);
    o.weight = "4";
    CHECK(pbwio_read_memory("a.node", node, sizeof node - 1, &o, &c, NULL) == PBWIO_OK);
    CHECK(c.dim == 2 && c.points[2] > 6 && c.weights[0] > 5 && c.weights[1] > 9);
    pbwio_free(&c);
    o.weight = NULL;
    o.columns = "z,x";
    CHECK(pbwio_read_memory("a.ply", ply.data, ply.size, &o, &c, NULL) == PBWIO_OK);
    CHECK(c.dim == 2 && c.points[0] < -2 && c.points[4] > 299 && c.triangle_count == 1 && c.triangles[2] == 2);
    pbwio_free(&c);
    o.columns = "tags,y";
    CHECK(pbwio_read_memory("a.ply", ply.data, ply.size, &o, &c, NULL) == PBWIO_ERROR_FORMAT);
    o.columns = NULL;
    o.dim = 2;
    CHECK(pbwio_read_memory("a.obj", obj.data, obj.size, &o, &c, NULL) == PBWIO_OK && c.dim == 2);
    CHECK(c.triangles[0] == 0 && c.triangles[1] == 2 && c.triangles[2] == 1);
    pbwio_free(&c);
    CHECK(pbwio_read_memory(NULL, "", 0, &plain, &c, NULL) == PBWIO_ERROR_ARGUMENT);
    CHECK(pbwio_read_memory("a", NULL, 1, &plain, &c, NULL) == PBWIO_ERROR_ARGUMENT);
    CHECK(pbwio_read("/no/such/file.xyz", &plain, &c, NULL) == PBWIO_ERROR_FILE);
}

/* Reads broken content in a block of its very size; whatever happens must happen properly. */
static void read_broken(const io_sample *s, const char *data, size_t size)
{
    char *copy = (char *)malloc(size + (size == 0));
    pbwio_cloud cloud;
    pbwio_error error;
    pbwio_status status;
    size_t i;
    memcpy(copy, data, size);
    peak = 0;
    error.text[0] = 0;
    status = pbwio_read_memory(s->name, copy, size, &plain, &cloud, &error);
    CHECK(peak <= io_bound(data, size));
    CHECK((status == PBWIO_OK) == (error.text[0] == 0) && (status == PBWIO_OK) == (cloud.count != 0));
    CHECK(status == PBWIO_OK || strncmp(error.text, s->name, strlen(s->name)) == 0);
    for (i = 0; i < cloud.count * (size_t)cloud.dim; i++) {
        CHECK(pbwio__finite(cloud.points[i]));
    }
    for (i = 0; i < 3 * cloud.triangle_count; i++) {
        CHECK(cloud.triangles[i] < cloud.count);
    }
    pbwio_free(&cloud);
    CHECK(held == 0);
    free(copy);
}

static void test_truncations(void)
{
    char buffer[1024];
    size_t size;
    int i;
    for (i = 0; i < IO_SAMPLES; i++) {
        io_sample s = io_get_sample(i, buffer);
        for (size = 0; size < s.size; size++) {
            read_broken(&s, s.data, size);
        }
    }
}

/* What a reader says of a file that lies: nothing of memory, and no byte beyond the file.  Returns whether it read. */
static int read_lie(const io_sample *s, const char *data, size_t size)
{
    pbwio_cloud cloud;
    pbwio_error error;
    const char *at;
    size_t byte;
    const pbwio_status status = pbwio_read_memory(s->name, data, size, &plain, &cloud, &error);
    if (status != PBWIO_OK) {
        at = strstr(error.text, ": byte ");
        if (!CHECK(status != PBWIO_ERROR_MEMORY && strstr(error.text, "memory") == NULL
                   && (at == NULL || (sscanf(at, ": byte %zu", &byte) == 1 && byte <= size)))) {
            test_say("%s", error.text);
        }
    }
    pbwio_free(&cloud);
    return status == PBWIO_OK;
}

/* In place of each number of each file, and of each four bytes, numbers that are too large; and of each byte a z. */
static void test_lies(void)
{
    static const char *const numbers[] = { "4000000000", "99999999999999", "1000000", "-1" };
    char buffer[1024], *data;
    size_t at, end, read = 0, lies = 0, n;
    int i, k;
    for (i = 0; i < IO_SAMPLES; i++) {
        const io_sample s = io_get_sample(i, buffer);
        data = (char *)malloc(s.size + 32);
        for (at = 0; at < s.size; at = end + 1) {
            for (end = at; end < s.size && s.data[end] >= '0' && s.data[end] <= '9'; end++) {
            }
            for (k = 0; k < 4 && end > at; k++, lies++) {
                n = strlen(numbers[k]);
                memcpy(data, s.data, at);
                memcpy(data + at, numbers[k], n);
                memcpy(data + at + n, s.data + end, s.size - end);
                read += (size_t)read_lie(&s, data, s.size + n - (end - at));
            }
        }
        for (at = 0; at + 4 <= s.size; at++) {
            for (k = 0; k < 2; k++, lies++) {
                memcpy(data, s.data, s.size);
                memcpy(data + at, k == 0 ? "\xf0\xff\xff\x7f" : "z", k == 0 ? 4 : 1);
                read += (size_t)read_lie(&s, data, s.size);
            }
        }
        free(data);
    }
    test_say("%zu of %zu were read", read, lies);
    CHECK(read > 0 && read < lies / 2);
}

static void test_flips(void)
{
    char buffer[1024], copy[1024];
    size_t bit;
    int i;
    for (i = 0; i < IO_SAMPLES; i++) {
        io_sample s = io_get_sample(i, buffer);
        for (bit = 0; bit < 8 * s.size; bit++) {
            memcpy(copy, s.data, s.size);
            copy[bit / 8] = (char)(copy[bit / 8] ^ 1 << bit % 8);
            read_broken(&s, copy, s.size);
        }
    }
}

static void test_no_memory(void)
{
    char buffer[1024];
    size_t k;
    int i;
    for (i = 0; i < 2 * IO_SAMPLES; i++) {
        io_sample s = io_get_sample(i / 2, buffer);
        once = i % 2;
        for (k = 1, requests = 1; k <= requests + 1; k++) {
            pbwio_cloud cloud;
            pbwio_status status;
            fail_at = k;
            requests = 0;
            status = pbwio_read_memory(s.name, s.data, s.size, &plain, &cloud, NULL);
            fail_at = 0;
            CHECK(status == PBWIO_OK || (status == PBWIO_ERROR_MEMORY && held == 0 && cloud.points == NULL));
            CHECK(status != PBWIO_OK || k > 1);
            pbwio_free(&cloud);
            CHECK(held == 0 && wrong_sizes == 0);
        }
        once = 0;
    }
}

/* At each level of the limit a file is read, or memory is short; what is held stays below it. */
static void test_limit(void)
{
    char buffer[1024];
    size_t most;
    int i, part, failures = 0;
    for (i = 0; i < IO_SAMPLES; i++) {
        io_sample s = io_get_sample(i, buffer);
        pbwio_cloud cloud;
        pbwio_status status;
        most_held = 0;
        CHECK_EQUAL(pbwio_read_memory(s.name, s.data, s.size, &plain, &cloud, NULL), PBWIO_OK);
        pbwio_free(&cloud);
        most = most_held;
        for (part = 1; part <= 8; part++) {
            counted.memory_limit = most * (size_t)part / 8;
            most_held = 0;
            status = pbwio_read_memory(s.name, s.data, s.size, &plain, &cloud, NULL);
            CHECK(status == PBWIO_OK || (status == PBWIO_ERROR_MEMORY && held == 0 && part < 8));
            CHECK(most_held <= counted.memory_limit);
            failures += status != PBWIO_OK;
            pbwio_free(&cloud);
        }
        counted.memory_limit = 0;
    }
    CHECK(failures > 4 * IO_SAMPLES);
}

/* A line of a megabyte, a table of many columns, a polygon of many corners, a PLY of many properties. */
static void test_long(void)
{
    size_t size = 1 << 20, i;
    char *text = (char *)malloc(size + 64);
    pbwio_cloud cloud;
    pbwio_error error;
    io_sample s;
    memset(&s, 0, sizeof s);
    s.data = text;
    memset(text, ' ', size);
    memcpy(text, "1 2 3", 5);
    memcpy(text + size - 8, "4\n5 6 7\n", 8);
    CHECK(pbwio_read_memory("a.xyz", text, size, &plain, &cloud, &error) == PBWIO_OK && cloud.count == 2);
    pbwio_free(&cloud);
    memset(text, '9', size);
    memcpy(text + size - 5, " 2 3\n", 5);
    CHECK(pbwio_read_memory("a.xyz", text, size, &plain, &cloud, &error) == PBWIO_ERROR_FORMAT);
    CHECK(strcmp(error.text, "a.xyz:1: column 1, \"999999999999999999999999...\", is not a finite number") == 0);
    for (i = 0; i < size; i += 2) {
        memcpy(text + i, "1 ", 2);
    }
    text[size - 1] = '\n';
    CHECK(pbwio_read_memory("a.xyz", text, size, &plain, &cloud, &error) == PBWIO_OK && cloud.count == 1);
    pbwio_free(&cloud);
    memcpy(text, "v 0 0 0\nf ", 10);
    s.name = "a.obj";
    read_broken(&s, text, size);
    for (i = 0; i + 20 < size; i += 20) {
        memcpy(text + i, "property uchar p\n   ", 20);
    }
    memcpy(text, "ply\nelement vertex 1", 20);
    s.name = "a.ply";
    read_broken(&s, text, i);
    CHECK(pbwio_read_memory("a.ply", text, i, &plain, &cloud, &error) == PBWIO_ERROR_FORMAT);
    memset(text, '\n', size);
    s.name = "a.xyz";
    read_broken(&s, text, size);
    memset(text, 0, size);
    read_broken(&s, text, size);
    s.name = "a.obj";
    read_broken(&s, text, size);
    s.name = "a.stl";
    read_broken(&s, text, size);
    free(text);
}

static void *all_samples(void *unused)
{
    (void)unused;
    test_samples();
    return NULL;
}

static void test_stack(void)
{
    pthread_attr_t attributes;
    pthread_t thread;
    int started;
    pthread_attr_init(&attributes);
    CHECK(pthread_attr_setstacksize(&attributes, 65536) == 0);
    started = pthread_create(&thread, &attributes, all_samples, NULL) == 0;
    if (started) {
        pthread_join(thread, NULL);
    }
    CHECK(started);
    pthread_attr_destroy(&attributes);
}

/* ---- writers ---- */

static const char *in_folder(const char *name)
{
    static char path[400];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static char *read_all(const char *name, size_t *size)
{
    FILE *file = fopen(in_folder(name), "rb");
    char *data = (char *)calloc(1, 1 << 20);
    *size = file == NULL ? 0 : fread(data, 1, (1 << 20) - 1, file);
    if (file != NULL) {
        fclose(file);
        unlink(in_folder(name));
    }
    return data;
}

/* count points, the last a duplicate of the first; weighted ones with some that are hidden. */
static void make_mesh(int dim, int weighted, size_t count, pbw_mesh *mesh)
{
    double *points = (double *)malloc((size_t)dim * count * sizeof *points);
    double *weights = (double *)malloc(count * sizeof *weights);
    size_t i;
    for (i = 0; i < (size_t)dim * count; i++) {
        points[i] = i % 7 == 0 ? (double)(next_random() % 100) / 8 - 5 : 10 * unit_random() - 5;
    }
    memcpy(points + (size_t)dim * (count - 1), points, (size_t)dim * sizeof *points);
    for (i = 0; i < count; i++) {
        weights[i] = 20 * unit_random();
    }
    CHECK(pbw_triangulate(dim, points, weighted ? weights : NULL, count, NULL, mesh) == PBW_OK);
    free(points);
    free(weights);
}

static void write_it(const char *name, const pbw_mesh *mesh, unsigned flags, const unsigned char *keep)
{
    pbwio_output output = counted_output();
    pbwio_error error;
    struct stat info;
    output.flags = flags;
    output.keep = keep;
    if (!CHECK(pbwio_write(in_folder(name), mesh, &output, &error) == PBWIO_OK)) {
        test_say("%s", error.text);
    }
    CHECK(held == 0 && stat(in_folder(name), &info) == 0);
}

/* The next numbers of a text, after an optional word. */
static const char *scan(const char *at, const char *word, int count, double *out)
{
    int i;
    at = at != NULL && word != NULL ? strstr(at, word) : at;
    at = at != NULL && word != NULL ? at + strlen(word) : at;
    for (i = 0; i < count && at != NULL; i++) {
        size_t length;
        at += strspn(at, " \n");
        length = strcspn(at, " \n<");
        at = pbwio__number(at, at + length, &out[i]) ? at + length : NULL;
    }
    return at;
}

static int same_number(double a, double b)
{
    return a <= b && a >= b;
}

static void check_points(const char *name, const pbw_mesh *mesh, const char *weight)
{
    pbwio_options options = { PBWIO_AUTO, 0, NULL, weight, NULL, 0, &counted };
    pbwio_cloud cloud;
    pbwio_error error;
    if (!CHECK(pbwio_read(in_folder(name), &options, &cloud, &error) == PBWIO_OK)) {
        test_say("%s", error.text);
        return;
    }
    CHECK(cloud.dim == mesh->dim && cloud.count == mesh->point_count);
    CHECK(memcmp(cloud.points, mesh->points, cloud.count * (size_t)cloud.dim * sizeof(double)) == 0);
    CHECK(weight == NULL || memcmp(cloud.weights, mesh->weights, cloud.count * sizeof(double)) == 0);
    pbwio_free(&cloud);
    unlink(in_folder(name));
}

static size_t kept_count(const pbw_mesh *mesh, const unsigned char *keep, size_t *hull)
{
    size_t corners = (size_t)mesh->dim + 1, count = 0, i;
    for (i = *hull = 0; i < corners * mesh->simplex_count; i++) {
        if (keep == NULL || keep[i / corners]) {
            pbw_index n = mesh->neighbors[i];
            count += i % corners == 0;
            *hull += n == PBW_NONE || (keep != NULL && !keep[n]);
        }
    }
    return count;
}

/* Area or volume of a simplex, up to a factor. */
static double size_of(const pbw_mesh *mesh, size_t simplex)
{
    pbwpic__view v;
    memset(&v, 0, sizeof v);
    v.mesh = mesh;
    v.half = 1;
    return pbwpic__size(&v, simplex);
}

/* Goes through facets of the boundary of what is kept, ids from base after before numbers and before after others:
   they are facets, as many as there should be, and turn counter-clockwise seen from outside, so that they enclose the
   size of what they bound. */
static const char *check_facets(const char *at, const pbw_mesh *mesh, int before, int base, int after)
{
    size_t dim = (size_t)mesh->dim, i, k, n, hull;
    double row[12], around = 0, inside = 0;
    kept_count(mesh, NULL, &hull);
    for (i = 0; i < hull && at != NULL; i++) {
        const double *p[3] = { NULL, NULL, NULL };
        at = scan(at, NULL, before + mesh->dim + after, row);
        for (k = 0; k < dim && at != NULL; k++) {
            n = (size_t)(row[(size_t)before + k] - base);
            CHECK(n < mesh->point_count);
            p[k] = mesh->points + dim * n;
        }
        if (at != NULL) {
            around += dim == 2 ? (p[0][0] * p[1][1] - p[0][1] * p[1][0])
                    : p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1])
                      + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2])
                      + p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
        }
    }
    for (i = 0; i < mesh->simplex_count; i++) {
        inside += size_of(mesh, i);
    }
    CHECK(at != NULL && inside > 0 && fabs(inside - around) <= 1e-9 * inside);
    return at;
}

/* A surface that was written: closed, outward, and around the volume of the simplices. */
static void check_surface(const char *name, const pbw_mesh *mesh, const unsigned char *keep)
{
    pbwio_cloud c;
    size_t i, j, hull, count = kept_count(mesh, keep, &hull);
    double inside = 0, around = 0, tolerance = strstr(name, ".stl") != NULL && name[0] != 't' ? 1e-3 : 1e-8;
    if (!CHECK(pbwio_read(in_folder(name), &plain, &c, NULL) == PBWIO_OK)) {
        return;
    }
    CHECK(c.dim == 3 && c.triangle_count == (mesh->dim == 3 ? hull : count));
    for (i = 0; i < c.triangle_count; i++) {
        const double *p = c.points + 3 * c.triangles[3 * i], *q = c.points + 3 * c.triangles[3 * i + 1];
        const double *r = c.points + 3 * c.triangles[3 * i + 2];
        around += mesh->dim == 3 ? (p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0])
                                    + p[2] * (q[0] * r[1] - q[1] * r[0]))
                                 : (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    }
    for (i = 0; i < mesh->simplex_count; i++) {
        inside += keep == NULL || keep[i] ? size_of(mesh, i) : 0;
    }
    CHECK(fabs(inside - around) <= tolerance * inside && inside > 0);
    for (i = 0; i < 3 * c.triangle_count && mesh->dim == 3 && strstr(name, ".stl") == NULL && keep == NULL; i++) {
        pbw_index a = c.triangles[i], b = c.triangles[i % 3 == 2 ? i - 2 : i + 1];
        int found = 0;
        for (j = 0; j < 3 * c.triangle_count; j++) {
            found += c.triangles[j] == b && c.triangles[j % 3 == 2 ? j - 2 : j + 1] == a;
        }
        CHECK(found == 1);
    }
    for (i = 0; i < c.count && strstr(name, ".stl") == NULL; i++) {  /* no point that is on no triangle */
        for (j = 0; j < 3 * c.triangle_count && c.triangles[j] != i; j++) {
        }
        CHECK(j < 3 * c.triangle_count);
    }
    pbwio_free(&c);
    unlink(in_folder(name));
}

/* Ids of simplices in a text: number columns before and after the ids are skipped. */
static void check_ids(const char *at, const pbw_mesh *mesh, int before, int base, int after)
{
    int corners = mesh->dim + 1, k;
    size_t i;
    double row[12];
    for (i = 0; i < mesh->simplex_count && at != NULL; i++) {
        at = scan(at, NULL, before + corners + after, row);
        for (k = 0; k < corners && at != NULL; k++) {
            CHECK(same_number(row[before + k], mesh->simplices[i * (size_t)corners + (size_t)k] + (double)base));
        }
    }
    CHECK(at != NULL);
}

/* The arrays of a binary .vtu, by the offsets in their tags. */
static void check_vtu(const pbw_mesh *mesh)
{
    static const char *const names[] = { "id", "points", "connectivity", "offsets", "types", "quality" };
    size_t size, i, a, n = (size_t)mesh->dim + 1;
    char *data = read_all("a.vtu", &size), *raw = strstr(data, "<AppendedData encoding=\"raw\">\n_"), tag[64];
    double offset;
    CHECK(raw != NULL && strstr(data, "</VTKFile>") == NULL);        /* zeros come first */
    for (a = 0; a < 6 && raw != NULL; a++) {
        const char *at;
        uint64_t bytes, want[6];
        want[0] = 4 * mesh->point_count;
        want[1] = 24 * mesh->point_count;
        want[2] = 4 * n * mesh->simplex_count;
        want[3] = want[5] = 8 * mesh->simplex_count;
        want[4] = mesh->simplex_count;
        snprintf(tag, sizeof tag, "Name=\"%s\"", names[a]);
        at = strstr(data, tag);
        at = at == NULL ? NULL : strstr(at, "offset=\"");
        if (!CHECK(at != NULL)) {
            break;
        }
        offset = (double)atol(at + 8);
        at = raw + 31 + (size_t)offset;
        memcpy(&bytes, at, 8);
        at += 8;
        CHECK(bytes == want[a] && (size_t)(at - data) + bytes <= size);
        CHECK(a != 2 || memcmp(at, mesh->simplices, bytes) == 0);
        for (i = 0; a == 1 && i < mesh->point_count; i++) {
            double p[3];
            memcpy(p, at + 24 * i, sizeof p);
            CHECK(memcmp(p, mesh->points + (size_t)mesh->dim * i, (size_t)mesh->dim * sizeof(double)) == 0);
        }
        for (i = 0; a == 3 && i < mesh->simplex_count; i++) {
            int64_t end;
            memcpy(&end, at + 8 * i, 8);
            CHECK(end == (int64_t)((i + 1) * n));
        }
        for (i = 0; a >= 4 && i < mesh->simplex_count; i++) {
            double quality = 0.5;
            if (a == 5) {
                memcpy(&quality, at + 8 * i, 8);
            }
            CHECK(a == 5 ? quality > 0 && quality <= 1 : at[i] == (mesh->dim == 3 ? 10 : 5));
        }
    }
    free(data);
}

/* Formats for solvers, which number points from 1 without gaps: sizes and groups of what is kept, as read back. */
static void test_solvers(int dim, const unsigned char *keep, const pbw_mesh *mesh)
{
    static const size_t across[2][4] = { { 2, 0, 1, 0 }, { 3, 2, 0, 1 } };    /* side S(k+1) is across from corner */
    size_t n = (size_t)dim + 1, size, i, j, k, hull, count = kept_count(mesh, keep, &hull), points = 0, facets = 0;
    size_t *simplex = (size_t *)malloc(count * sizeof *simplex);
    unsigned char *used = (unsigned char *)calloc(mesh->point_count, 2), *outer = used + mesh->point_count;
    double row[8];
    char *data;
    const char *at, *line;
    for (i = j = 0; i < mesh->simplex_count; i++) {
        for (k = 0; k < n && (keep == NULL || keep[i]); k++) {
            pbw_index other = mesh->neighbors[n * i + k];
            simplex[j] = i;
            used[mesh->simplices[n * i + k]] = 1;
            for (size = 0; size < n && (other == PBW_NONE || (keep != NULL && !keep[other])); size++) {
                outer[mesh->simplices[n * i + size]] |= size != k;
            }
        }
        j += keep == NULL || keep[i] != 0;
    }
    for (i = 0; i < mesh->point_count; i++) {
        points += used[i];
        facets += outer[i];
    }
    write_it("a.su2", mesh, 0, keep);
    data = read_all("a.su2", &size);
    scan(data, "NDIME=", 1, row);
    scan(data, "NPOIN=", 1, row + 1);
    scan(data, "MARKER_TAG= boundary\nMARKER_ELEMS=", 1, row + 2);
    at = scan(data, "NELEM=", 1, row + 3);
    CHECK(same_number(row[0], dim) && same_number(row[1], (double)points) && same_number(row[2], (double)hull)
          && same_number(row[3], (double)count));
    at = scan(at, NULL, 2 + dim, row);
    CHECK(same_number(row[0], dim == 3 ? 10 : 5));
    at = scan(data, "MARKER_ELEMS=", 1 + (dim + 1) * (int)(hull < 2 ? hull : 1), row);
    CHECK(at != NULL && same_number(row[1], dim == 3 ? 5 : 3));
    free(data);
    write_it("a.inp", mesh, 0, keep);
    data = read_all("a.inp", &size);
    for (line = data, i = 0; *line == '*'; i++) {                    /* section by section: names, then rows */
        static const char *const heads[] = { "*NODE, NSET=NALL\n", "*ELEMENT, TYPE=C%s, ELSET=DOMAIN\n",
                                             "*NSET, NSET=BOUNDARY\n", "*SURFACE, NAME=BOUNDARY, TYPE=ELEMENT\n" };
        size_t rows[4], number, side;
        char head[64];
        rows[0] = points;
        rows[1] = count;
        rows[2] = facets;
        rows[3] = hull;
        snprintf(head, sizeof head, i < 4 ? heads[i] : "", dim == 3 ? "3D4" : "PS3");
        CHECK(i < 4 && strncmp(line, head, strlen(head)) == 0);
        for (j = 0, line = strchr(line, '\n') + 1; *line != 0 && *line != '*'; j++, line = strchr(line, '\n') + 1) {
            number = strtoul(line, NULL, 10);
            CHECK(number >= 1 && number <= (i < 2 ? j + 1 : rows[i == 2 ? 0 : 1]));
            if (i == 3 && number >= 1 && number <= count) {
                side = strtoul(strchr(line, 'S') + 1, NULL, 10);
                side = n * simplex[number - 1] + across[dim - 2][(side - 1) % n];
                CHECK(mesh->neighbors[side] == PBW_NONE || (keep != NULL && !keep[mesh->neighbors[side]]));
            }
        }
        CHECK(i < 4 && j == rows[i]);
    }
    CHECK(i == 4);
    free(data);
    free(simplex);
    free(used);
}

static void test_formats(int dim, int weighted)
{
    static const char *const surfaces[] = { "a.obj", "a.ply", "a.stl", "t.ply", "t.stl", "a.off" };
    pbw_mesh mesh;
    char *data;
    size_t size, i, hull, count, n = (size_t)dim + 1;
    double row[8];
    const char *at;
    unsigned char *keep;
    memset(&mesh, 0, sizeof mesh);
    make_mesh(dim, weighted, 300, &mesh);
    keep = (unsigned char *)malloc(mesh.simplex_count);
    for (i = 0; i < mesh.simplex_count; i++) {
        keep[i] = mesh.points[(size_t)dim * mesh.simplices[n * i]] < 0;
    }
    count = kept_count(&mesh, NULL, &hull);
    write_it("a.xyz", &mesh, 0, NULL);
    check_points("a.xyz", &mesh, weighted ? (dim == 3 ? "4" : "3") : NULL);
    write_it("a.csv", &mesh, 0, NULL);
    check_points("a.csv", &mesh, weighted ? "weight" : NULL);
    write_it("a.node", &mesh, 0, NULL);
    check_points("a.node", &mesh, weighted ? (dim == 3 ? "4" : "3") : NULL);
    for (i = 0; i < 6; i++) {
        write_it(surfaces[i], &mesh, surfaces[i][0] == 't' ? PBWIO_TEXT : 0, NULL);
        check_surface(surfaces[i], &mesh, NULL);
        write_it(surfaces[i], &mesh, surfaces[i][0] == 't' ? PBWIO_TEXT : 0, keep);
        check_surface(surfaces[i], &mesh, keep);
    }
    write_it("a.vtu", &mesh, 0, NULL);
    check_vtu(&mesh);
    write_it("t.vtu", &mesh, PBWIO_TEXT, NULL);
    data = read_all("t.vtu", &size);
    at = strstr(data, "Name=\"connectivity\"");
    check_ids(at == NULL ? NULL : strchr(at, '>') + 1, &mesh, 0, 0, 0);
    free(data);
    write_it("a.ele", &mesh, 0, NULL);
    data = read_all("a.ele", &size);
    at = scan(data, NULL, 3, row);
    CHECK(same_number(row[0], (double)count) && same_number(row[1], (double)n));
    check_ids(at, &mesh, 1, 0, 0);
    free(data);
    write_it("a.neigh", &mesh, 0, NULL);
    data = read_all("a.neigh", &size);
    at = scan(data, NULL, 2, row);
    for (i = 0; i < n * mesh.simplex_count && at != NULL; i++) {
        at = scan(at, NULL, i % n == 0 ? 2 : 1, row);
        CHECK(same_number(row[i % n == 0], mesh.neighbors[i] == PBW_NONE ? -1.0 : (double)mesh.neighbors[i]));
    }
    free(data);
    write_it("a.mesh", &mesh, 0, NULL);
    data = read_all("a.mesh", &size);
    at = scan(data, "Vertices", 1, row);
    CHECK(at != NULL && same_number(row[0], (double)mesh.point_count));
    at = scan(at, NULL, dim, row);
    CHECK(memcmp(row, mesh.points, (size_t)dim * sizeof(double)) == 0);
    at = scan(data, dim == 3 ? "Triangles" : "Edges", 1, row);
    CHECK(same_number(row[0], (double)hull));
    check_facets(at, &mesh, 0, 1, 1);
    at = scan(data, dim == 3 ? "Tetrahedra" : "Triangles", 1, row);
    CHECK(same_number(row[0], (double)count));
    check_ids(at, &mesh, 0, 1, 1);
    free(data);
    write_it("t.msh", &mesh, PBWIO_TEXT, NULL);
    data = read_all("t.msh", &size);
    at = scan(data, "$Elements", 8, row);
    CHECK(at != NULL && same_number(row[1], (double)(count + hull)) && same_number(row[7], (double)hull));
    at = check_facets(at, &mesh, 1, 1, 0);
    at = scan(at, NULL, 4, row);
    CHECK(at != NULL && same_number(row[0], dim) && same_number(row[2], dim == 3 ? 4 : 2));
    check_ids(at, &mesh, 1, 1, 0);
    free(data);
    write_it("a.msh2", &mesh, 0, NULL);
    data = read_all("a.msh2", &size);
    at = scan(data, "$Elements", 1, row);
    CHECK(at != NULL && same_number(row[0], (double)(count + hull)));
    at = check_facets(at, &mesh, 5, 1, 0);
    check_ids(at, &mesh, 5, 1, 0);
    free(data);
    write_it("a.face", &mesh, 0, NULL);
    data = read_all("a.face", &size);
    at = scan(data, NULL, 2, row);
    CHECK(same_number(row[0], (double)hull) && same_number(row[1], 1));
    check_facets(at, &mesh, 1, 0, 1);
    free(data);
    write_it("n.node", &mesh, PBWIO_NO_ORPHANS, NULL);
    data = read_all("n.node", &size);
    scan(data, NULL, 1, row);
    CHECK(same_number(row[0], (double)(mesh.point_count - mesh.duplicate_count - mesh.hidden_count)));
    CHECK(mesh.duplicate_count > 0 && (mesh.hidden_count > 0) == (weighted != 0));
    free(data);
    write_it("k.ele", &mesh, PBWIO_NO_ORPHANS, keep);
    data = read_all("k.ele", &size);
    scan(data, NULL, 1, row);
    CHECK(same_number(row[0], (double)kept_count(&mesh, keep, &hull)));
    free(data);
    test_solvers(dim, NULL, &mesh);
    test_solvers(dim, keep, &mesh);
    free(keep);
    pbw_free(&mesh);
}

static void test_refusals(void)
{
    pbw_mesh mesh;
    pbw_options options;
    pbwio_error error;
    static const double points[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1 };
    memset(&mesh, 0, sizeof mesh);
    memset(&options, 0, sizeof options);
    CHECK(pbwio_write("a.vtu", &mesh, NULL, &error) == PBWIO_ERROR_ARGUMENT);
    options.flags = PBW_NO_NEIGHBORS;
    CHECK(pbw_triangulate(3, points, NULL, 4, &options, &mesh) == PBW_OK);
    CHECK(pbwio_write(NULL, &mesh, NULL, &error) == PBWIO_ERROR_ARGUMENT);
    CHECK(pbwio_write("a.what", &mesh, NULL, &error) == PBWIO_ERROR_ARGUMENT);
    CHECK(strcmp(error.text, "a.what: no format of that name is written") == 0);
    CHECK(pbwio_write("a.obj", &mesh, NULL, &error) == PBWIO_ERROR_ARGUMENT);
    CHECK(strcmp(error.text, "a.obj: this format needs neighbors, the mesh has none") == 0);
    CHECK(pbwpic_write("a.svg", &mesh, NULL, &error) == PBWIO_ERROR_ARGUMENT);
    CHECK(pbwio_write("/no/such/folder/a.vtu", &mesh, NULL, &error) == PBWIO_ERROR_FILE);
    CHECK(strcmp(error.text, "/no/such/folder/a.vtu: No such file or directory") == 0);
    write_it("a.mesh", &mesh, 0, NULL);
    unlink(in_folder("a.mesh"));
    pbw_free(&mesh);
}

/* How many lines follow a head in a file, up to the next line that starts with an asterisk; 0 without it. */
static size_t lines_after(const char *data, const char *head)
{
    const char *at = strstr(data, head);
    size_t count = 0;
    for (at = at != NULL ? strchr(at, '\n') : NULL; at != NULL && at[1] != 0 && at[1] != '*'; at = strchr(at + 1, '\n')) {
        count++;
    }
    return count;
}

/* Regions 0 and 7 of a mesh and three patches, one of them PBW_NONE: each a group of its own, read back whole. */
static void test_groups(void)
{
    static const char *const names[] = { "a.msh", "t.msh", "a.vtu", "t.vtu", "a.inp" };
    static const char *const groups[] = { "1 1 \"edges\"\n2 1 \"patch_0\"\n2 2 \"patch_1\"\n2 2147483647 \"hole\"\n"
                                          "3 1 \"region_0\"\n3 8 \"region_7\"\n", "$Entities\n0 1 9 2\n" };
    pbw_mesh mesh;
    pbwio_output output;
    pbwio_cloud cloud;
    pbw_index *regions, *patches, edges[4];
    size_t i, k, count[2] = { 0, 0 }, facets[3] = { 0, 0, 0 }, size;
    char *data;
    memset(&mesh, 0, sizeof mesh);
    memset(&output, 0, sizeof output);
    output.build = &counted;
    make_mesh(3, 0, 300, &mesh);
    regions = (pbw_index *)malloc(mesh.simplex_count * sizeof *regions);
    patches = (pbw_index *)malloc(4 * mesh.simplex_count * sizeof *patches);
    for (i = 0; i < mesh.simplex_count; i++) {
        regions[i] = mesh.points[3 * mesh.simplices[4 * i]] < 0 ? 0 : 7;
        count[regions[i] == 7]++;
    }
    for (i = 0; i < 4 * mesh.simplex_count; i++) {
        const pbw_index n = mesh.neighbors[i];
        const size_t patch = n == PBW_NONE ? i % 3 : i / 4 < n ? i / 4 % 3 : n % 3;
        patches[i] = patch == 2 ? PBW_NONE : (pbw_index)patch;
        facets[patch] += n == PBW_NONE || regions[i / 4] < regions[n];
    }
    for (i = 0; i < 4; i++) {
        edges[i] = mesh.simplices[i % 3];
    }
    output.regions = regions;
    output.patches = patches;
    output.edges = edges;
    output.edge_count = 2;
    for (i = 0; i < 5; i++) {
        output.flags = names[i][0] == 't' ? PBWIO_TEXT : 0;
        CHECK(pbwio_write(in_folder(names[i]), &mesh, &output, NULL) == PBWIO_OK);
        if (i < 4 && CHECK(pbwio_read(in_folder(names[i]), &plain, &cloud, NULL) == PBWIO_OK)) {
            CHECK(cloud.count == mesh.point_count
                  && memcmp(cloud.points, mesh.points, 24 * mesh.point_count) == 0);
            CHECK(cloud.tetrahedron_count == mesh.simplex_count
                  && cloud.triangle_count == facets[0] + facets[1] + facets[2]);
            pbwio_free(&cloud);
        }
    }
    data = read_all("t.msh", &size);
    CHECK(strstr(data, groups[0]) != NULL && strstr(data, groups[1]) != NULL);
    free(data);
    data = read_all("a.inp", &size);
    CHECK(lines_after(data, "ELSET=region_0") == count[0] && lines_after(data, "ELSET=region_7") == count[1]);
    CHECK(lines_after(data, "NAME=patch_0") == facets[0] && lines_after(data, "NAME=patch_1") == facets[1]);
    CHECK(lines_after(data, "NAME=hole") == facets[2] && lines_after(data, "NSET=edges") == 3);
    free(data);
    for (k = 1; k < 5; k++) {
        output.format = k < 3 ? PBWIO_MSH : PBWIO_INP;
        fail_at = k < 3 ? k : k - 1;
        requests = 0;
        CHECK(pbwio_write(in_folder("a.out"), &mesh, &output, NULL) == PBWIO_ERROR_MEMORY && held == 0);
        fail_at = 0;
    }
    for (i = 0; i < 5; i++) {
        unlink(in_folder(names[i]));
    }
    free(regions);
    free(patches);
    pbw_free(&mesh);
}

/* ---- columns and heights */

/* Reads a file with the weight from a column, and compares coordinate 2 (dim 3), or the height, and that weight. */
static void check_column(const char *name, const char *column, int dim, const double *heights, const double *values,
                         size_t count)
{
    pbwio_options options;
    pbwio_cloud cloud;
    size_t i, wrong = 0;
    memset(&options, 0, sizeof options);
    options.build = &counted;
    options.weight = column;
    options.dim = dim;
    if (!CHECK(pbwio_read(in_folder(name), &options, &cloud, NULL) == PBWIO_OK)) {
        test_say("%s, %s", name, column != NULL ? column : "-");
        return;
    }
    CHECK(cloud.count == count && cloud.dim == dim && (cloud.heights != NULL) == (dim == 2 && heights != NULL));
    for (i = 0; i < count && cloud.count == count; i++) {
        const double z = dim == 3 ? cloud.points[3 * i + 2] : cloud.heights != NULL ? cloud.heights[i] : 0;
        wrong += heights != NULL && !same_number(z, heights[i]);
        wrong += column != NULL && !same_number(cloud.weights[i], values[i]);
    }
    if (!CHECK(wrong == 0)) {
        test_say("%s, column %s: %zu of %zu wrong", name, column != NULL ? column : "-", wrong, count);
    }
    pbwio_free(&cloud);
}

/* Writes a text file, and looks for a piece of it. */
static void check_line(const char *name, const pbw_mesh *mesh, const pbwio_output *output, const char *line, int is)
{
    size_t size;
    char *data;
    CHECK(pbwio_write(in_folder(name), mesh, output, NULL) == PBWIO_OK);
    data = read_all(name, &size);
    if (!CHECK((strstr(data, line) != NULL) == is)) {
        test_say("%s: %s", name, line);
    }
    free(data);
}

static void test_columns(void)
{
    static const double points[] = { 0, 0, 4, 0, 4, 3, 0, 3 }, heights[] = { 1.5, -2, 0.1, 1e300 };
    static const char *const solid[] = { "h.obj", "h.ply", "h.off", "h.vtu", "h.msh", "h.msh2", "h.mesh", "h.csv",
                                         "h.xyz" };
    static double depths[] = { 10, 20, 30, 1e-300 }, salts[] = { 0.25, 0.5, 0.75, -1 };
    pbwio_column columns[3];
    pbwio_group groups[2];
    pbw_index of_points[4] = { 0, 1, PBW_NONE, 1 };
    pbwio_output output;
    pbw_mesh mesh;
    size_t i;
    memset(&mesh, 0, sizeof mesh);
    memset(&output, 0, sizeof output);
    output.build = &counted;
    memset(groups, 0, sizeof groups);
    CHECK(pbw_triangulate(2, points, NULL, 4, NULL, &mesh) == PBW_OK);
    columns[0].name = (char *)(uintptr_t)"depth, \"m\"";
    columns[1].name = (char *)(uintptr_t)"a&b<c";
    columns[2].name = NULL;
    columns[0].values = depths;
    columns[1].values = columns[2].values = salts;
    groups[0].tag = 7;
    groups[1].tag = -3;
    output.columns = columns;
    output.column_count = 3;
    output.heights = heights;
    output.groups = groups;
    output.group_count = 2;
    output.point_groups = of_points;
    output.base = 1;
    for (i = 0; i < sizeof solid / sizeof *solid; i++) {
        CHECK(pbwio_write(in_folder(solid[i]), &mesh, &output, NULL) == PBWIO_OK);
        check_column(solid[i], NULL, 3, heights, NULL, 4);
        check_column(solid[i], NULL, 2, heights, NULL, 4);
    }
    check_column("h.csv", "a&b<c", 2, heights, salts, 4);
    check_column("h.csv", "attribute_3", 3, heights, salts, 4);
    check_column("h.ply", "depth,_\"m\"", 3, heights, depths, 4);
    check_column("h.ply", "attribute_3", 2, heights, salts, 4);
    check_line("h.csv", &mesh, &output, "x,y,z,\"depth, \"\"m\"\"\",a&b<c,attribute_3,marker\n0,0,1.5,10,0.25,0.25,7\n",
               1);
    check_line("h.mesh", &mesh, &output, "Dimension 3\nVertices\n4\n0 0 1.5 7\n4 0 -2 -3\n4 3 0.1 0\n", 1);
    output.flags = PBWIO_TEXT;
    CHECK(pbwio_write(in_folder("t.vtu"), &mesh, &output, NULL) == PBWIO_OK);
    check_column("t.vtu", "attribute_3", 3, heights, salts, 4);
    check_line("t.vtu", &mesh, &output, "Name=\"depth, &#34;m&#34;\" NumberOfComponents=\"1\" format=\"ascii\">\n"
               "10\n20\n30\n1e-300\n", 1);
    check_line("t.vtu", &mesh, &output, "Name=\"a&#38;b&#60;c\"", 1);
    check_line("t.vtu", &mesh, &output, "Name=\"marker\" NumberOfComponents=\"1\" format=\"ascii\">\n"
               "7\n-3\n0\n-3\n", 1);
    check_column("h.vtu", "attribute_3", 2, heights, salts, 4);
    CHECK(pbwio_write(in_folder("h.node"), &mesh, &output, NULL) == PBWIO_OK);
    check_column("h.node", "6", 2, NULL, heights, 4);
    check_line("h.node", &mesh, &output, "4 2 4 1\n1 0 0 10 0.25 0.25 1.5 7\n2 4 0 20 0.5 0.5 -2 -3\n"
               "3 4 3 30 0.75 0.75 0.1 0\n", 1);
    check_line("h.ele", &mesh, &output, "2 3 0\n1 ", 1);
    check_line("h.edge", &mesh, &output, "4 1\n1 ", 1);
    check_line("h.neigh", &mesh, &output, "\n2 ", 1);
    check_line("h.neigh", &mesh, &output, " 0", 0);
    check_line("h.inp", &mesh, &output, "1,0,0,1.5\n", 1);
    check_line("h.inp", &mesh, &output, "TYPE=S3", 1);
    check_line("h.su2", &mesh, &output, "NPOIN= 4\n0 0\n4 0\n4 3\n", 1);
    for (i = 0; i < 4; i++) {                        /* floats */
        depths[i] = (double)(float)(i == 3 ? 7.5 : heights[i]);
    }
    output.heights = depths;
    check_line("h.stl", &mesh, &output, "vertex 0 0 1.5\n", 1);
    for (i = 0; i < sizeof solid / sizeof *solid; i++) {
        (void)unlink(in_folder(solid[i]));
    }
    pbw_free(&mesh);
}

/* Heights of tables and arrays: there, missing in a row, no numbers, all 0. */
static void test_heights(void)
{
    static const struct { const char *name, *text; int heights; } files[] = {
        { "a.csv", "x,y,z\n0,0,1\n1,0,2\n0,1,3\n", 1 }, { "b.csv", "z,x,y\n1,0,0\n2,1,0\n3,0,1\n", 1 },
        { "c.csv", "x,y,kind\n0,0,1\n1,0,2\n0,1,3\n", 0 }, { "d.xyz", "0 0 1\n1 0 2\n0 1 3\n", 1 },
        { "e.xyz", "0 0 1\n1 0 2\n0 1\n", 0 }, { "f.xyz", "0 0 1\n1 0 b\n0 1 3\n", 0 },
        { "g.xyz", "0 0\n1 0\n0 1\n", 0 }, { "h.xyz", "0 0 0\n1 0 0\n0 1 0\n", 0 },
        { "i.json", "[[0,0,1],[1,0,2],[0,1,3]]", 1 }, { "j.json", "[[0,0,1],[1,0],[0,1,3]]", 0 },
        { "k.json", "[{\"x\":0,\"y\":0,\"z\":1},{\"x\":1,\"z\":2,\"y\":0},{\"y\":1,\"z\":3,\"x\":0}]", 1 },
        { "l.json", "[{\"x\":0,\"y\":0,\"z\":1},{\"x\":1,\"y\":0},{\"y\":1,\"z\":3,\"x\":0}]", 0 },
        { "m.json", "[[0,0],[1,0],[0,1]]", 0 }, { "n.obj", "v 0 0 1\nv 1 0 2\nv 0 1 3\n", 1 },
        { "o.off", "OFF\n3 0 0\n0 0 1\n1 0 2\n0 1 3\n", 1 }, { "p.node", "3 3 0 0\n1 0 0 1\n2 1 0 2\n3 0 1 3\n", 1 },
        { "q.node", "3 2 1 0\n1 0 0 1\n2 1 0 2\n3 0 1 3\n", 0 }, { "r.mesh", "MeshVersionFormatted 2\nDimension 3\n"
          "Vertices\n3\n0 0 1 0\n1 0 2 0\n0 1 3 0\nEnd\n", 1 },
        { "s.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float z\nproperty float x\nproperty float y\n"
          "end_header\n1 0 0\n2 1 0\n3 0 1\n", 1 },
        { "t.geojson", "{\"type\":\"LineString\",\"coordinates\":[[0,0,1],[1,0,2],[0,1,3]]}", 1 }
    };
    pbwio_options options;
    pbwio_cloud cloud;
    size_t i, k;
    memset(&options, 0, sizeof options);
    options.build = &counted;
    options.dim = 2;
    for (i = 0; i < sizeof files / sizeof *files; i++) {
        if (CHECK(pbwio_read_memory(files[i].name, files[i].text, strlen(files[i].text), &options, &cloud, NULL)
                  == PBWIO_OK)) {
            CHECK(cloud.count == 3 && cloud.dim == 2 && cloud.points[2] == 1 && cloud.points[5] == 1);
            if (!CHECK((cloud.heights != NULL) == files[i].heights)) {
                test_say("%s", files[i].name);
            }
            for (k = 0; k < 3 && cloud.heights != NULL; k++) {
                CHECK(cloud.heights[k] == (double)k + 1);
            }
        }
        pbwio_free(&cloud);
    }
}

static size_t files_in_folder(void)
{
    DIR *list = opendir(folder);
    size_t count = 0;
    while (list != NULL && readdir(list) != NULL) {
        count++;
    }
    CHECK(list != NULL && closedir(list) == 0);
    return count - 2;                                /* . and .. */
}

typedef struct saving { const char *name; int letter, runs; } saving;

/* Writes half of a file; then other runs write to the same output, before the other half. */
static void emit_halves(void *user, FILE *file)
{
    const saving *s = (const saving *)user;
    saving other = *s;
    pbwio_error error;
    int i;
    other.letter++;
    other.runs--;
    for (i = 0; i < 200000; i++) {
        putc(s->letter, file);
        if (i == 100000 && s->runs > 0) {
            fflush(file);
            CHECK(pbwio_save(in_folder(s->name), emit_halves, &other, NULL, &error) == PBWIO_OK);
        }
    }
}

static void check_letters(const char *name, int letter)
{
    size_t size, i = 0;
    char *bytes = read_all(name, &size);
    while (i < size && bytes[i] == letter) {
        i++;
    }
    CHECK(size == 200000 && i == size);
    free(bytes);
}

static void put_text(const char *name, const char *text)
{
    FILE *file = fopen(in_folder(name), "w");
    CHECK(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
}

/* Runs at the same time on one output: it is whole, the last one's; no file beside it is touched, linked or not. */
static void test_runs_at_once(void)
{
    static const char *const others[] = { "a.part", "a.part.1", "victim" };
    saving s = { "a", 'A', 3 };
    char name[100], *bytes;
    pbwio_error error;
    size_t i, size;
    for (i = 0; i < 3; i++) {
        put_text(others[i], "mine");
    }
    for (i = 0; i < 4; i++) {                        /* the next names are taken: by files, links, a dangling link */
        snprintf(name, sizeof name, "a.part.%lu-%u", (unsigned long)getpid(), (unsigned)i);
        if (i % 2 == 0) {
            put_text(name, "mine");
        } else {
            CHECK(symlink(i == 1 ? "victim" : "none", in_folder(name)) == 0);
        }
    }
    CHECK(pbwio_save(in_folder("a"), emit_halves, &s, NULL, &error) == PBWIO_OK);
    check_letters("a", 'A');
    CHECK_EQUAL(files_in_folder(), 3 + 4);
    for (i = 0; i < 4; i++) {
        snprintf(name, sizeof name, "a.part.%lu-%u", (unsigned long)getpid(), (unsigned)i);
        CHECK(unlink(in_folder(name)) == 0);
    }
    for (i = 0; i < 3; i++) {
        bytes = read_all(others[i], &size);
        CHECK(size == 4 && memcmp(bytes, "mine", 4) == 0);
        free(bytes);
    }
    for (i = 0; i < 3; i++) {                        /* names as long as the system allows */
        char longest[256];
        memset(longest, 'n', 255);
        memcpy(longest + 198 + i, "\xe2\x82\xac", 3);
        longest[255] = 0;
        s.name = longest;
        CHECK(pbwio_save(in_folder(longest), emit_halves, &s, NULL, &error) == PBWIO_OK);
        check_letters(longest, 'A');
    }
    CHECK_EQUAL(files_in_folder(), 0);
}

/* A file-size limit stands for a full disk: the old file stays, and nothing else. */
static void test_full_disk(void)
{
    static const pbwio_format formats[] = { PBWIO_VTU, PBWIO_MSH, PBWIO_STL, PBWIO_OBJ, PBWIO_INP };
    struct rlimit old, small;
    struct stat info;
    pbw_mesh mesh;
    pbwio_error error;
    size_t i, k;
    FILE *file = fopen(in_folder("a.out"), "w");
    memset(&mesh, 0, sizeof mesh);
    make_mesh(3, 0, 3000, &mesh);
    CHECK(file != NULL && fputs("old", file) >= 0 && fclose(file) == 0);
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old);
    small = old;
    for (i = 0; i < 6; i++) {
        pbwio_output output = counted_output();
        pbwio_status status;
        output.format = formats[i % 5];
        small.rlim_cur = i < 3 ? 5000 : 1;
        setrlimit(RLIMIT_FSIZE, &small);
        status = i < 5 ? pbwio_write(in_folder("a.out"), &mesh, &output, &error)
                       : pbwpic_write(in_folder("a.out"), &mesh, NULL, &error);
        setrlimit(RLIMIT_FSIZE, &old);
        CHECK(status == PBWIO_ERROR_FILE && strstr(error.text, "File too large") != NULL);
        CHECK(stat(in_folder("a.out"), &info) == 0 && info.st_size == 3);
        CHECK_EQUAL(files_in_folder(), 1);
    }
    unlink(in_folder("a.out"));
    if (access("/dev/full", W_OK) == 0) {
        pbwio_output output = counted_output();
        output.format = PBWIO_VTU;
        CHECK(pbwio_write("/dev/full", &mesh, &output, &error) == PBWIO_ERROR_FILE);
        CHECK(strcmp(error.text, "/dev/full: No space left on device") == 0);
        CHECK(stat("/dev/full", &info) == 0 && S_ISCHR(info.st_mode));
    }
    for (k = 1; k < 10; k++) {
        pbwio_output output = counted_output();
        pbwio_status status;
        output.format = k < 5 ? PBWIO_OBJ : PBWIO_INP;
        output.flags = PBWIO_NO_ORPHANS;
        fail_at = k < 5 ? k : k - 4;
        requests = 0;
        status = pbwio_write(in_folder("a.out"), &mesh, &output, &error);
        fail_at = 0;
        CHECK(status == PBWIO_ERROR_MEMORY && held == 0 && stat(in_folder("a.out"), &info) != 0);
    }
    pbw_free(&mesh);
}

/* Also where squares, or even differences, of coordinates over- or underflow. */
static void test_pictures(void)
{
    static const double scales[4] = { 1, 1e300, 1e-300, 1.7e308 };
    int k;
    for (k = 0; k < 8; k++) {
        const int dim = 2 + k / 4;
        const double scale = scales[k % 4];
        double points[600];
        pbw_mesh mesh;
        size_t size, paths = 0, i;
        char *data, *at;
        memset(&mesh, 0, sizeof mesh);
        for (i = 0; i < 200 * (size_t)dim; i++) {
            points[i] = scale * (2 * unit_random() - 1);
        }
        CHECK(pbw_triangulate(dim, points, NULL, 200, NULL, &mesh) == PBW_OK);
        for (mesh.dim = -1; mesh.dim < 5; mesh.dim += mesh.dim == 1 ? 3 : 1) {
            CHECK(pbwpic_write(in_folder("a.svg"), &mesh, NULL, NULL) == PBWIO_ERROR_ARGUMENT);
        }
        mesh.dim = dim;
        CHECK(pbwpic_write(in_folder("a.svg"), NULL, NULL, NULL) == PBWIO_ERROR_ARGUMENT);
        CHECK(pbwpic_write(in_folder("a.svg"), &mesh, NULL, NULL) == PBWIO_OK);
        data = read_all("a.svg", &size);
        for (at = data; (at = strstr(at, "<path ")) != NULL; at++) {
            paths++;
        }
        CHECK(strstr(data, "viewBox=") < strchr(data, '>') && strstr(data, "height=") > strchr(data, '>'));
        CHECK(strncmp(data, "<svg ", 5) == 0 && strcmp(data + size - 7, "</svg>\n") == 0);
        CHECK(strstr(data, "nan") == NULL && strstr(data, "inf") == NULL);
        CHECK(dim == 2 ? paths == mesh.simplex_count : paths > 20 && paths < mesh.simplex_count);
        free(data);
        pbw_free(&mesh);
    }
}

/* Models with normals: what is written is read, and the forms of faces in .obj. */
static void test_models(void)
{
    static const double points[12] = { 0, 0, 0, 1, 0, 0.1, 1, 1, 1e-300, 0, 1, 1.0 / 3 };
    static const double normals[12] = { 0, 0, 1, 0, 1, 0, 1, 0, 0, 0.6, 0.8, 0 };
    static const pbw_index triangles[6] = { 0, 1, 2, 0, 2, 3 }, turned[6] = { 1, 0, 3, 1, 3, 2 };
    static const struct { const char *name; int faces, normals; } files[] = {
        { "m.ply", 1, 1 }, { "m.obj", 1, 1 }, { "m.off", 1, 0 }, { "m.stl", 1, 0 }, { "m.xyz", 0, 0 },
        { "m.csv", 0, 1 }
    };
    static const char *const texts[] = {             /* of the last three some faces have no normals */
        "v 0 0 0\nvn 0 0 1\nv 1 0 0\nvn 0 1 0\nv 1 1 0\nv 0 1 0\nvn 1 0 0\nvn 0 0.6 0.8\n"
        "f 1/7/2 2/7/1 3/7/4 4/7/3\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 0\nvn 1 0 0\nvn 0 1 1\r\nf 1//-3\t2//-4 3//-1\r\n"
        "f 1//2 3//4 4//3 \n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 0\nf 1//1 2 3//1\nf 1//1 3//1 4//1\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1/1 2/1 3/1\nf 1/1 3/1 4/1\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
    };
    pbwmodel_content content;
    pbwio_cloud cloud, read;
    pbwio_error error;
    size_t i, j;
    memset(&content, 0, sizeof content);
    content.dim = 3;
    content.point_count = 4;
    content.triangle_count = 2;
    content.points = points;
    content.normals = normals;
    content.triangles = triangles;
    for (i = 0; i < 2 * sizeof files / sizeof files[0]; i++) {
        const char *path = in_folder(files[i / 2].name);
        CHECK_EQUAL(pbwmodel_write(path, &content, i % 2 ? PBWIO_TEXT : 0, &error), PBWIO_OK);
        if (!CHECK_EQUAL(pbwio_read(path, &plain, &cloud, &error), PBWIO_OK)) {
            test_say("%s", error.text);
            continue;
        }
        CHECK_EQUAL(cloud.triangle_count, files[i / 2].faces ? 2 : 0);
        if (strcmp(files[i / 2].name, "m.stl") != 0) {
            CHECK(cloud.count == 4 && memcmp(cloud.points, points, sizeof points) == 0);
            CHECK(!files[i / 2].faces || memcmp(cloud.triangles, triangles, sizeof triangles) == 0);
        }
        CHECK_EQUAL(pbwmodel_read_normals(path, &cloud, &read), files[i / 2].normals);
        CHECK(!files[i / 2].normals || (read.count == 4 && memcmp(read.points, normals, sizeof normals) == 0));
        CHECK(!files[i / 2].normals || !files[i / 2].faces
              || (read.triangle_count == 2 && memcmp(read.triangles, triangles, sizeof triangles) == 0));
        pbwio_free(&read);
        pbwio_free(&cloud);
        CHECK(unlink(path) == 0);
    }
    for (i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        const char *path = in_folder("n.obj");
        FILE *file = fopen(path, "wb");
        CHECK(file != NULL && fputs(texts[i], file) >= 0 && fclose(file) == 0);
        CHECK_EQUAL(pbwio_read(path, &plain, &cloud, &error), PBWIO_OK);
        CHECK_EQUAL(pbwmodel_read_normals(path, &cloud, &read), i < 2);
        for (j = 0; j < 6 && i < 2; j++) {
            CHECK_EQUAL(read.triangles[j], turned[j]);
        }
        CHECK(i > 1 || (read.count == 4 && read.points[2] > 0 && read.points[4] > 0 && read.points[6] > 0));
        pbwio_free(&read);
        pbwio_free(&cloud);
        CHECK(unlink(path) == 0);
    }
    CHECK_EQUAL(pbwmodel_write(in_folder("m.su2"), &content, 0, &error), PBWIO_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwmodel_write("/no/such/m.ply", &content, 0, &error), PBWIO_ERROR_FILE);
    content.triangle_count = 0;
    CHECK_EQUAL(pbwmodel_write(in_folder("m.stl"), &content, 0, &error), PBWIO_ERROR_ARGUMENT);
}

/* Copies a text of at most 511 letters with the name of the folder for FOLDER. */
static void fill_in(const char *from, char to[512])
{
    to[0] = 0;
    for (; *from != 0; from++) {
        int here = strncmp(from, "FOLDER", 6) == 0;
        snprintf(to + strlen(to), 512 - strlen(to), here ? "%s" : "%.1s", here ? folder : from);
        from += here ? 5 : 0;
    }
}

/* The program of examples/program: exit status and last line for right and wrong uses. */
#define EVERY "vtu msh msh2 mesh inp su2 node ele neigh face edge obj ply stl off xyz csv txt pts asc dat tsv " \
              "svg html geojson"
static void test_program(void)
{
    static const struct { const char *arguments, *says; int status; } uses[] = {
        { "--help", "  pbw mesh model.obj --inside -o mesh.msh -o picture.svg", 0 },
        { "", "  pbw live     --help   insert, remove and move points by a script", 0 },
        { "a.xyz b.xyz", "pbw: more than one input: a.xyz and b.xyz", 2 },
        { "--frobnicate a.xyz", "pbw: pbw mesh has no option --frobnicate; see pbw mesh --help", 2 },
        { "a.xyz -o FOLDER/a",
          "pbw: -o FOLDER/a: its ending tells the format, else --format; pbw mesh writes " EVERY, 2 },
        { "a.xyz -o", "pbw: -o: FILE is needed", 2 },
        { "a.xyz --dim 4", "pbw: --dim 4: a whole number from 2 to 3 is needed", 2 },
        { "a.xyz --cut 1,2,3",
          "pbw: --cut 1,2,3: A,B,C,D is needed, a direction A,B,C other than 0,0,0 and D from -1 to 1", 2 },
        { "--generate nothing 5", "pbw: --generate nothing: one of uniform, gauss, ball, sphere, lattice, "
          "clusters, lines, "
          "spiral, plane, anisotropic, moment is needed", 2 },
        { "/no/such.xyz", "pbw: /no/such.xyz: No such file or directory", 1 },
        { "--generate uniform 2", "pbw: the points do not span the space: there are no simplices", 1 },
        { "--generate uniform 50000 --memory-limit 1M",
          "pbw: out of memory within --memory-limit 1M: 50000 points in 3D "
          "need about 16 MB, and more where many lie on few lines", 1 },
        { "--generate uniform 100 --inside",
          "pbw: --inside: what is generated has no faces; --surface names a model that has", 2 },
        { "--generate uniform 100 -o /no/such/a.vtu", "pbw: -o /no/such/a.vtu: there is no folder /no/such/", 2 },
        { "--generate lattice 27 --quiet -o FOLDER/a.node -o FOLDER/a.svg -o FOLDER/a.html", "", 0 },
        { "FOLDER/a.node --quiet --any-order --no-check --threads 1 -o FOLDER/b.csv", "", 0 },
        { "- --dim 2 --weights z --quiet -o FOLDER/c.obj < FOLDER/b.csv", "", 0 },
        { "mesh --help", "  pbw mesh model.obj --inside -o mesh.msh -o picture.svg", 0 },
        { "sample --help", "  pbw sample model.obj --fill lattice -o points.csv", 0 },
        { "check --help", "  pbw check mesh.msh", 0 },
        { "convert --help", "  pbw convert mesh.msh -o mesh.vtu", 0 },
        { "bench --help", "  pbw bench points.csv --threads 2", 0 },
        { "view --help", "  pbw view mesh.msh -o mesh.html --cut 1,0,0,0", 0 },
        { "view a.xyz -o a.vtu",
          "pbw: -o a.vtu: its ending tells the format, else --format; pbw view writes html", 2 },
        { "view FOLDER/a.node", "open this in a browser: FOLDER/a.html", 0 },
        { "view --generate uniform 100 -o /no/such/a.html",
          "pbw: -o /no/such/a.html: there is no folder /no/such/", 2 },
        { "mesh --generate lattice 27 --quiet -o FOLDER/d.obj", "", 0 },
        { "sample", "pbw: an input is needed; see pbw sample --help", 2 },
        { "sample --dim 2 a.obj", "pbw: pbw sample has no option --dim, pbw mesh has", 2 },
        { "sample --count 5 --radius 1 a.obj", "pbw: --count 5 and --radius 1 exclude each other", 2 },
        { "sample --uniform --radius 1 a.obj", "pbw: --uniform and --radius 1 exclude each other", 2 },
        { "sample --radius 0 a.obj", "pbw: --radius 0: a number above 0 is needed", 2 },
        { "sample --fill water a.obj", "pbw: --fill water: one of lattice, poisson is needed", 2 },
        { "sample a.obj -o a.vtu", "pbw: -o a.vtu: its ending tells the format, else --format; "
          "pbw sample writes ply obj off xyz csv txt pts asc dat tsv", 2 },
        { "sample FOLDER/a.node", "pbw: FOLDER/a.node: a model with faces is needed", 1 },
        { "sample FOLDER/d.obj --quiet --radius 1e-9", "pbw: more samples than an index can number", 1 },
        { "sample FOLDER/d.obj --quiet --count 500 --text -o FOLDER/e.ply", "", 0 },
        { "sample FOLDER/d.obj --quiet --count 500 --uniform --facet-normals -o FOLDER/e.csv", "", 0 },
        { "sample FOLDER/d.obj --quiet --radius 0.4 --thin --fill poisson -o FOLDER/f.xyz", "", 0 },
        { "sample FOLDER/d.obj --quiet --radius 0.4 --fill lattice -o FOLDER/f.xyz", "", 0 },
        { "mesh FOLDER/f.xyz --quiet --inside --surface FOLDER/d.obj -o FOLDER/f.stl", "", 0 },
        { "mesh FOLDER/f.xyz --quiet --inside",
          "pbw: --inside needs a model with faces in 3D, FOLDER/f.xyz has none", 1 },
        { "convert FOLDER/e.ply", "pbw: an output is needed; see pbw convert --help", 2 },
        { "convert FOLDER/e.ply FOLDER/e.vtu", "pbw: FOLDER/e.ply: it has no tetrahedra, and no triangles of one plane; "
          "pbw mesh makes them of its points", 1 },
        { "convert FOLDER/e.ply FOLDER/e.stl", "pbw: FOLDER/e.stl: there are no triangles", 1 },
        { "convert FOLDER/e.ply FOLDER/e.obj --quiet", "", 0 },
        { "convert FOLDER/d.obj FOLDER/d.off FOLDER/d.stl -o FOLDER/d.ply --quiet", "", 0 },
        { "check FOLDER/d.ply --quiet", "", 0 },
        { "check FOLDER/d.stl --quiet --threads 1", "", 0 },
        { "check FOLDER/e.obj --quiet", "", 0 },
        { "check", "pbw: an input is needed; see pbw check --help", 2 },
        { "bench --generate uniform 2", "pbw: the points do not span the space: there are no simplices", 1 }
    };
    static const char *const files[] = { "a.html", "a.node", "a.svg", "b.csv", "c.obj", "d.obj", "d.off", "d.ply",
                                         "d.stl", "e.ply", "e.csv", "e.obj", "f.xyz", "f.stl" };
    char command[1024], line[512], last[512], arguments[512], says[512];
    size_t i;
    if (access(program, X_OK) != 0) {
        test_skip("there is no program pbw beside this one");
        return;
    }
    for (i = 0; i < sizeof uses / sizeof uses[0]; i++) {
        FILE *pipe;
        int status;
        last[0] = 0;
        fill_in(uses[i].arguments, arguments);
        fill_in(uses[i].says, says);
        snprintf(command, sizeof command, "%s %s 2>&1", program, arguments);
        pipe = popen(command, "r");
        while (pipe != NULL && fgets(line, sizeof line, pipe) != NULL) {
            line[strcspn(line, "\n")] = 0;
            strcpy(last, line);
        }
        status = pipe == NULL ? -1 : pclose(pipe);
        if (!CHECK(WIFEXITED(status) && WEXITSTATUS(status) == uses[i].status && strcmp(last, says) == 0)) {
            test_say("%s: %d, %s", uses[i].arguments, status, last);
        }
    }
    for (i = 0; i < sizeof files / sizeof files[0]; i++) {
        CHECK(unlink(in_folder(files[i])) == 0);
    }
    test_end();
}

/* Starts the program with a pipe from its standard error, and for its input if that is not NULL. */
static pid_t start_program(const char *arguments, int *input, int *errors)
{
    char command[1024];
    int in[2], err[2];
    pid_t pid;
    snprintf(command, sizeof command, "exec %s %s", program, arguments);
    if (pipe(in) != 0 || pipe(err) != 0) {
        return -1;
    }
    pid = fork();
    if (pid == 0) {
        signal(SIGINT, SIG_DFL);
        dup2(in[0], 0);
        dup2(err[1], 2);
        close(in[1]);
        execl("/bin/sh", "sh", "-c", command, (char *)NULL);
        _exit(127);
    }
    close(in[0]);
    close(err[1]);
    *input = in[1];
    *errors = err[0];
    return pid;
}

/* What an interrupted program said; it must have ended by the signal itself. */
static void end_program(pid_t pid, int errors, char said[512])
{
    ssize_t got, length = 0;
    int status = 0;
    while ((got = read(errors, said + length, (size_t)(511 - length))) > 0) {
        length += got;
    }
    said[length] = 0;
    close(errors);
    CHECK(waitpid(pid, &status, 0) == pid && WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
}

/* Ctrl-C while the program waits for its input; while it waits for a reader of its second output. */
static void test_interrupt(void)
{
    char arguments[512], said[512];
    int input, errors, reader;
    pid_t pid;
    FILE *file;
    if (access(program, X_OK) != 0) {
        test_skip("there is no program pbw beside this one");
        return;
    }
    snprintf(arguments, sizeof arguments, "mesh - --quiet -o %s", in_folder("a.obj"));
    pid = start_program(arguments, &input, &errors);
    CHECK(pid > 0 && kill(pid, SIGINT) == 0);
    close(input);
    end_program(pid, errors, said);
    CHECK(access(in_folder("a.obj"), F_OK) != 0);
    file = fopen(in_folder("i.xyz"), "w");
    CHECK(file != NULL && fputs("0 0 0\n1 0 0\n0 1 0\n0 0 1\n", file) >= 0 && fclose(file) == 0);
    CHECK(mkfifo(in_folder("fifo"), 0600) == 0);
    fill_in("mesh FOLDER/i.xyz --quiet --format csv -o FOLDER/a.obj -o FOLDER/fifo -o FOLDER/b.obj", arguments);
    pid = start_program(arguments, &input, &errors);
    while (pid > 0 && access(in_folder("a.obj"), F_OK) != 0) {
        usleep(1000);
    }
    CHECK(pid > 0 && kill(pid, SIGINT) == 0);
    reader = open(in_folder("fifo"), O_RDONLY | O_NONBLOCK);         /* in case the signal came before its open */
    end_program(pid, errors, said);
    close(reader);
    close(input);
    fill_in("pbw: interrupted; written: FOLDER/a.obj", arguments);
    CHECK(strncmp(said, arguments, strlen(arguments)) == 0 && strstr(said, "; not written: ") != NULL);
    CHECK(access(in_folder("b.obj"), F_OK) != 0);
    CHECK(unlink(in_folder("a.obj")) == 0 && unlink(in_folder("fifo")) == 0 && unlink(in_folder("i.xyz")) == 0);
    test_end();
}

/* With a comma as decimal point nothing may change. */
static void test_locale(void)
{
    static const char *const names[] = { "de_DE.UTF-8", "de_DE.utf8", "de_DE", "fr_FR.UTF-8", "fr_FR.utf8", "fr_FR" };
    size_t i = 0;
    while (i < 6 && setlocale(LC_ALL, names[i]) == NULL) {
        i++;
    }
    if (i == 6) {
        test_skip("no locale with a decimal comma is installed");
        return;
    }
    test_samples();
    test_bad_files();
    test_formats(3, 1);
    setlocale(LC_ALL, "C");
    test_end();
}

typedef struct watch { int calls, stop_at; double last; } watch;

static int on_progress(void *user, pbw_stage stage, double done)
{
    watch *w = (watch *)user;
    CHECK(stage == PBW_STAGE_WORK && done >= w->last && done <= 1);
    w->last = done;
    return ++w->calls == w->stop_at;
}

/* A long table, and a mesh in several formats: progress ascends, and each call of it may end the work. */
static void test_progress(void)
{
    static const char *const names[] = { "p.xyz", "p.vtu", "p.msh", "p.mesh", "p.inp", "p.su2", "p.ply", "p.obj.gz" };
    pbw_mesh mesh;
    pbwio_error error;
    size_t i;
    memset(&mesh, 0, sizeof mesh);
    make_mesh(3, 0, 9000, &mesh);
    for (i = 0; i < sizeof names / sizeof names[0]; i++) {
        pbwio_output output = counted_output();
        pbwio_cloud cloud;
        watch w = { 0, 0, 0 };
        int calls, k;
        counted.progress = on_progress;
        counted.progress_user = &w;
        CHECK_EQUAL(pbwio_write(in_folder(names[i]), &mesh, &output, &error), PBWIO_OK);
        calls = w.calls;
        CHECK(calls > 0);
        for (k = 1; k <= calls; k += 1 + calls / 4) {
            w.calls = 0;
            w.last = 0;
            w.stop_at = k;
            CHECK_EQUAL(pbwio_write(in_folder("stopped"), &mesh, NULL, &error), PBWIO_ERROR_ARGUMENT);
            output.format = pbwio_format_of(names[i]);
            CHECK_EQUAL(pbwio_write(in_folder(i == 7 ? "stopped.gz" : "stopped"), &mesh, &output, &error),
                        PBWIO_CANCELLED);
            CHECK(held == 0 && access(in_folder("stopped"), F_OK) != 0 && access(in_folder("stopped.gz"), F_OK) != 0);
            output.format = PBWIO_AUTO;
        }
        w.calls = w.stop_at = 0;
        w.last = 0;
        CHECK_EQUAL(pbwio_read(in_folder(names[i]), &plain, &cloud, &error), PBWIO_OK);
        pbwio_free(&cloud);
        calls = w.calls;
        CHECK(calls > 2);
        for (k = 1; k <= calls; k += 1 + calls / 4) {
            w.calls = 0;
            w.last = 0;
            w.stop_at = k;
            CHECK_EQUAL(pbwio_read(in_folder(names[i]), &plain, &cloud, &error), PBWIO_CANCELLED);
            CHECK(held == 0 && cloud.points == NULL);
        }
        counted.progress = NULL;
        unlink(in_folder(names[i]));
    }
    CHECK_EQUAL(wrong_sizes, 0);
    pbw_free(&mesh);
}

int main(int argc, char **argv)
{
    static const struct { const char *name; void (*run)(void); } tests[] = {
        { "numbers are read and written exactly", test_numbers }, { "good files", test_samples },
        { "columns, weights and dimensions", test_choices }, { "bad files", test_bad_files },
        { "every truncation", test_truncations }, { "every flipped bit", test_flips },
        { "numbers that lie", test_lies },
        { "memory runs out", test_no_memory }, { "memory_limit", test_limit }, { "progress", test_progress },
        { "long lines", test_long }, { "a small stack", test_stack },
        { "what writers refuse", test_refusals }, { "groups", test_groups }, { "columns", test_columns },
        { "heights", test_heights }, { "a full disk", test_full_disk }, { "runs at once", test_runs_at_once },
        { "pictures", test_pictures }, { "models with normals", test_models }
    };
    size_t i;
    test_start(argc, argv, 0);
    counted.resize = count_resize;
    plain.build = &counted;
    snprintf(program, sizeof program, "%.*spbw", (int)(strrchr(argv[0], '/') == NULL ? 0
             : strrchr(argv[0], '/') + 1 - argv[0]), argv[0]);
    strcpy(folder, "/tmp/pbw-test-XXXXXX");
    if (mkdtemp(folder) == NULL) {
        return 1;
    }
    for (i = 0; i < sizeof tests / sizeof tests[0]; i++) {
        if (test_begin("%s", tests[i].name)) {
            tests[i].run();
            test_end();
        }
    }
    for (i = 0; i < 4; i++) {
        if (test_begin("every format, %zuD%s", 2 + i / 2, i % 2 ? ", weighted" : "")) {
            test_formats(2 + (int)i / 2, (int)i % 2);
            test_end();
        }
    }
    if (test_begin("the program")) {
        test_program();
    }
    if (test_begin("the program, interrupted")) {
        test_interrupt();
    }
    if (test_begin("another locale")) {
        test_locale();
    }
    rmdir(folder);
    return test_finish();
}
