/* fuzz_io.c: bytes read as a file of every format, and what must hold afterwards; the models among them sampled.
       clang -g -O1 -fsanitize=fuzzer,address,undefined tests/fuzz_io.c -o fuzz_io -lpthread -lm
       ./fuzz_io tests/corpus/io
       cc -O2 -DFUZZ_MAIN tests/fuzz_io.c -o fuzz_io -lpthread -lm && ./fuzz_io --count 1000000 --seed 1
       ./fuzz_io FILE ...      (FUZZ_MAIN too) reads these files */
#if defined(PBW_FUZZ_MAIN) && !defined(FUZZ_MAIN)
#define FUZZ_MAIN
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t in_use, most_in_use;

/* Counts what is held; while a block is resized both sizes are. */
static void *count_resize(void *user, void *ptr, size_t old_size, size_t new_size)
{
    void *block = NULL;
    (void)user;
    if (new_size != 0) {
        block = malloc(new_size);
        if (block == NULL) {
            return NULL;
        }
        in_use += new_size;
        most_in_use = in_use > most_in_use ? in_use : most_in_use;
    }
    if (ptr != NULL) {
        if (block != NULL) {
            memcpy(block, ptr, old_size < new_size ? old_size : new_size);
        }
        in_use -= old_size;
        free(ptr);
    }
    return block;
}

#define PBW_IMPLEMENTATION
#include "../pbw.h"
#define PBW_IO_IMPLEMENTATION
#include "../examples/lib/pbw_io.h"
#define PBW_SAMPLE_IMPLEMENTATION
#include "../examples/lib/pbw_sample.h"
#include "io_samples.h"
#include "test.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

/* What is wrong with the outcome of a reader, NULL if nothing is. */
static const char *judge(const pbwio_cloud *cloud, pbwio_status status, const pbwio_error *error, size_t bound)
{
    size_t i;
    if (most_in_use > bound) {
        return "too much memory";
    }
    if (status != PBWIO_OK) {
        size_t length = strlen(error->text);
        return in_use != 0 ? "memory held after a failure"
             : cloud->count != 0 || cloud->points != NULL || cloud->triangles != NULL || cloud->tetrahedra != NULL
             ? "not empty after a failure"
             : length == 0 || length >= sizeof error->text || strchr(error->text, '\n') != NULL ? "no proper message"
             : strncmp(error->text, "fuzz:", 5) != 0 ? "a message without the name of the file" : NULL;
    }
    if (cloud->dim < 2 || cloud->dim > 3 || cloud->count == 0) {
        return "no points, and no failure";
    }
    for (i = 0; i < cloud->count * (size_t)cloud->dim; i++) {
        if (!pbwio__finite(cloud->points[i])) {
            return "a coordinate that is not finite";
        }
    }
    for (i = 0; cloud->weights != NULL && i < cloud->count; i++) {
        if (!pbwio__finite(cloud->weights[i])) {
            return "a weight that is not finite";
        }
    }
    for (i = 0; i < 3 * cloud->triangle_count; i++) {
        if (cloud->triangles[i] >= cloud->count) {
            return "a triangle with a point that is none";
        }
    }
    for (i = 0; i < 4 * cloud->tetrahedron_count; i++) {
        if (cloud->tetrahedra[i] >= cloud->count) {
            return "a tetrahedron with a point that is none";
        }
    }
    return NULL;
}

static int grow_tired(void *patience, pbw_stage stage, double done)
{
    (void)stage;
    return !(done >= 0 && done <= 1) || --*(int *)patience < 0;
}

/* What is wrong with samples of a model, whatever it is like; NULL: nothing is. */
static const char *sample(const pbwio_cloud *cloud, size_t seed)
{
    static const unsigned flags[] = { 0, PBWSAMPLE_NORMALS, PBWSAMPLE_NORMALS | PBWSAMPLE_THIN, PBWSAMPLE_LATTICE };
    pbwsample_model model;
    pbwsample_options options;
    pbw_options build;
    pbwsample_report report;
    pbwsample_set set;
    pbw_status status;
    int way, patience;
    size_t i;
    memset(&report, 0, sizeof report);
    memset(&model, 0, sizeof model);
    model.points = cloud->points;
    model.point_count = cloud->count;
    model.triangles = cloud->triangles;
    model.triangle_count = cloud->triangle_count;
    status = pbwsample_inspect(&model, NULL, &report);
    if ((status == PBW_OK) != (model.triangle_count > 0 && report.area > 0 && report.area <= DBL_MAX)) {
        return "a surface without an area, or an area without a surface";
    }
    for (way = 0; way < 4; way++) {          /* uniform, Poisson, inside by count, inside by radius */
        patience = 8;
        memset(&set, 0, sizeof set);
        memset(&options, 0, sizeof options);
        memset(&build, 0, sizeof build);
        build.threads = 1;
        build.resize = count_resize;
        options.seed = seed;
        options.flags = flags[way == 2 ? 0 : seed / 4 % 4];
        build.progress = grow_tired;
        build.progress_user = &patience;
        options.build = &build;
        options.count = way < 3 ? 1 + seed % 23 : 0;
        options.radius = way < 3 ? 0 : sqrt(report.area / 40);
        status = way == 0 ? pbwsample_uniform(&model, &options, &set)
               : way == 1 ? pbwsample_poisson(&model, &options, &set) : pbwsample_volume(&model, &options, &set);
        if (status != PBW_OK && (set.count != 0 || (way < 2 && set.points != NULL))) {
            return "samples after a failure";
        }
        if (status == PBW_OK && way < 3 && set.count != options.count) {
            return "not as many samples as asked for";
        }
        for (i = 0; i < 3 * set.count; i++) {
            if (!pbwio__finite(set.points[i]) || (set.normals != NULL && !pbwio__finite(set.normals[i]))) {
                return "a sample that is not finite";
            }
        }
        for (i = 0; i < set.count; i++) {
            if (set.triangles[i] != PBW_NONE && set.triangles[i] >= model.triangle_count) {
                return "a sample on a triangle that is none";
            }
        }
        pbwsample_free(&set);
    }
    return NULL;
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size)
{
    static const char *const columns[] = { NULL, NULL, "2,1", "x,y", "1,2,3" };
    static const char *const weights[] = { NULL, NULL, NULL, "4", "w" };
    int format;
    for (format = PBWIO_AUTO; format <= PBWIO_POLY; format++) {
        pbwio_options options;
        pbw_options build;
        pbwio_cloud cloud;
        pbwio_error error;
        pbwio_status status;
        const char *fault;
        memset(&options, 0, sizeof options);
        memset(&build, 0, sizeof build);
        build.resize = count_resize;
        options.build = &build;
        options.format = (pbwio_format)format;
        options.columns = columns[size % 5];
        options.weight = weights[size / 5 % 5];
        options.dim = size % 7 == 6 ? 2 : size % 7 == 5 ? 3 : 0;
        options.flags = size % 11 == 0 ? PBWIO_DECIMAL_COMMA : 0;
        in_use = most_in_use = 0;
        status = pbwio_read_memory("fuzz", data, size, &options, &cloud, &error);
        fault = judge(&cloud, status, &error, io_bound(data, size) + (format == PBWIO_POLY ? 24 * size : 0));
        if (fault == NULL && format == PBWIO_AUTO && cloud.dim == 3 && cloud.triangle_count <= 100) {
            fault = sample(&cloud, size);
        }
        pbwio_free(&cloud);
        if (fault != NULL || in_use != 0) {
            printf("format %d: %s\n", format, fault != NULL ? fault : "memory held at the end");
            fflush(stdout);
            abort();
        }
    }
    return 0;
}

#ifdef FUZZ_MAIN
enum { MOST = 4096 };

static uint64_t state;

static size_t below(size_t n)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (size_t)(state % n);
}

/* One change: a bit, a byte, a piece cut out, doubled, or a word put in. */
static size_t mutate(unsigned char *bytes, size_t size)
{
    static const char *const words[] = {
        "0", "-1", "1e999", "nan", "4294967295", "4294967296", "18446744073709551616", "1e-400", " ", "\n", "\r\n",
        "#", "\\\n", ",", ";", "\"", "v ", "f ", "element vertex 99999999\n", "property list uchar int x\n",
        "end_header\n", "vertex ", "endloop\n", "OFF\n", "-", "/", "0x1p3", "1.", ".", "999999999999999999",
        "[", "]", "{\"x\":1,\"y\":2}", "\"coordinates\":", "$Nodes\n", "$Elements\n", "Vertices ", "Tetrahedra ",
        "C ", "<DataArray ", "format=\"appended\" ", "offset=\"", "<AppendedData encoding=\"raw\">_",
        "POLYGONS ", "CELLS ", "OFFSETS vtktypeint64\n", "SCALARS region int\n", "CELL_DATA ", "facet ", "end ",
        "\"points\":", "easting,northing,", "*ELSET, ELSET=a\n", "*SURFACE, NAME=b\n", ", GENERATE", "*NODE\n",
        "*ELEMENT, TYPE=S4\n", "4 1 2 3 4\n", "2 1\n", "NELEM= ", "MARKER_TAG= ", "NPOIN= "
    };
    size_t kind = below(6), at = below(size + 1), length = 1 + below(1 + below(32)), grow;
    const char *word = words[below(sizeof words / sizeof words[0])];
    if (kind <= 1 && at < size) {
        bytes[at] = (unsigned char)(kind == 0 ? bytes[at] ^ 1u << below(8) : below(256));
    } else if (kind == 2) {
        length = length < size - at ? length : size - at;
        memmove(bytes + at, bytes + at + length, size - at - length);
        size -= length;
    } else if (kind >= 3) {
        grow = kind == 3 ? (length < size - at ? length : size - at) : strlen(word);
        if (size + grow <= MOST) {
            memmove(bytes + at + grow, bytes + at, size - at);
            if (kind > 3) {
                memcpy(bytes + at, word, grow);
            }
            size += grow;
        }
    }
    return size;
}

int main(int argc, char **argv)
{
    static unsigned char bytes[1 << 20];
    static char buffer[1024];
    unsigned char *copy;
    long n;
    int i;
    if (argc > 1 && argv[1][0] != '-') {
        for (i = 1; i < argc; i++) {
            FILE *file = fopen(argv[i], "rb");
            if (file != NULL) {
                LLVMFuzzerTestOneInput(bytes, fread(bytes, 1, sizeof bytes, file));
                fclose(file);
            }
        }
        return 0;
    }
    test_start(argc, argv, 200000);
    state = test_seed * 0x9e3779b97f4a7c15u + 1;
    if (test_begin("readers: %ld broken files, seed %llu", test_count, (unsigned long long)test_seed)) {
        for (n = 0; n < test_count; n++) {
            io_sample s = io_get_sample((int)below(IO_SAMPLES), buffer);
            size_t size = s.size, changes = 1 + below(6);
            memcpy(bytes, s.data, size);
            while (changes-- > 0) {
                size = mutate(bytes, size);
            }
            copy = (unsigned char *)malloc(size);                    /* of that very size, for the sanitizers */
            if (copy != NULL || size == 0) {
                if (size != 0) {
                    memcpy(copy, bytes, size);
                }
                CHECK(LLVMFuzzerTestOneInput(copy, size) == 0);
            }
            free(copy);
        }
        test_end();
    }
    return test_finish();
}
#endif
