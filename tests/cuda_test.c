/* cuda_test.c: pbw_cuda.cu against the CPU, byte for byte: the zoo, and all kinds of points and weights at sizes that
   reach every rung.  Linked with a pbw_cuda.cu that was compiled for few points too (PBW_CUDA_FEW). */
#define PBW_IMPLEMENTATION
#include "../pbw.h"
#include "test.h"
#include "meshes.h"

static long by_gpu, by_cpu;                     /* builds of PBW_OK, by who made them */

/* Both builds of one input, and the comparison. */
static void compare(int dim, const double *points, const double *weights, size_t count, unsigned flags)
{
    pbw_mesh cpu, gpu;
    pbw_options options;
    pbw_status expected, status;
    char message[256] = "";
    memset(&options, 0, sizeof options);
    options.flags = flags;
    expected = pbw_triangulate(dim, points, weights, count, &options, &cpu);
    options.backend = pbw_cuda_backend(0);
    options.message = message;
    options.message_size = sizeof message;
    status = pbw_triangulate(dim, points, weights, count, &options, &gpu);
    if (!CHECK_EQUAL(status, expected)) {
        test_say("%s", message);
    }
    if (status == expected && (status == PBW_OK || status == PBW_DEGENERATE)) {
        CHECK(meshes_equal(&cpu, &gpu));
        by_gpu += status == PBW_OK && gpu.statistics.by_backend;
        by_cpu += status == PBW_OK && !gpu.statistics.by_backend;
    }
    pbw_free(&cpu);
    pbw_free(&gpu);
}

static void test_zoo(void)
{
    zoo animals;
    size_t i;
    zoo_fill(&animals);
    for (i = 0; i < animals.count; i++) {
        const zoo_input *in = animals.items + i;
        if (in->count > 0 && test_begin("zoo: %s", in->name)) {
            compare(in->dim, in->points, in->weights, in->count, 0);
            test_end();
        }
    }
    zoo_free(&animals);
}

static void test_kinds(size_t count)
{
    int dim, kind, weight_kind;
    double *points = (double *)malloc(count * 3 * sizeof *points);
    double *weights = (double *)malloc(count * sizeof *weights);
    for (dim = 2; dim <= 3 && points != NULL && weights != NULL; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            size_t n = kind == INPUT_MOMENT ? 200 : count;
            input_fill(kind, dim, n, (uint64_t)test_seed, points);
            if (test_begin("%dD %s, %lu", dim, input_name(kind), (unsigned long)n)) {
                compare(dim, points, NULL, n, 0);
                test_end();
            }
        }
        for (weight_kind = 0; weight_kind < INPUT_WEIGHTS_KINDS; weight_kind++) {
            for (kind = 0; kind < 2; kind++) {
                int points_kind = kind == 0 ? INPUT_UNIFORM : INPUT_LATTICE;
                if (test_begin("%dD %s, weights %s, %lu", dim, input_name(points_kind),
                               input_weights_name(weight_kind), (unsigned long)count)) {
                    input_fill(points_kind, dim, count, (uint64_t)test_seed, points);
                    input_fill_weights(weight_kind, dim, count, (uint64_t)test_seed, points, weights);
                    compare(dim, points, weights, count, 0);
                    test_end();
                }
            }
        }
    }
    free(points);
    free(weights);
}

/* Random small sets on tiny grids: all ties there are. */
static void test_random(void)
{
    uint64_t state = test_seed;
    long i;
    if (test_begin("random points on grids, %ld sets", test_count)) {
        for (i = 0; i < test_count; i++) {
            double points[3 * 400], weights[400];
            int dim = 2 + (int)input_below(&state, 2), side = 2 + (int)input_below(&state, 30), weighted;
            size_t count = 8 + input_below(&state, 392), k;
            for (k = 0; k < count * (size_t)dim; k++) {
                points[k] = (double)input_below(&state, (uint32_t)side);
            }
            weighted = input_below(&state, 3) == 0;
            for (k = 0; k < count; k++) {
                weights[k] = (double)input_below(&state, 4);
            }
            compare(dim, points, weighted ? weights : NULL, count, 0);
        }
        test_end();
    }
}

static void test_forms(void)
{
    const size_t count = 5000;
    size_t i;
    double *points = (double *)malloc(count * 4 * sizeof *points);
    float *floats = (float *)malloc(count * 3 * sizeof *floats);
    pbw_options options;
    pbw_mesh a, b;
    memset(&options, 0, sizeof options);
    input_fill(INPUT_UNIFORM, 3, count, 1, points);
    for (i = 0; i < count * 3; i++) {
        floats[i] = (float)points[i];
    }
    if (test_begin("without neighbors")) {
        compare(3, points, NULL, count, PBW_NO_NEIGHBORS);
        test_end();
    }
    if (test_begin("floats")) {
        pbw_triangulatef(3, floats, NULL, count, NULL, &a);
        options.backend = pbw_cuda_backend(0);
        CHECK_EQUAL(pbw_triangulatef(3, floats, NULL, count, &options, &b), PBW_OK);
        CHECK(b.statistics.by_backend && meshes_equal(&a, &b));
        pbw_free(&a);
        pbw_free(&b);
        test_end();
    }
    if (test_begin("strides")) {
        for (i = count; i-- > 0;) {
            memmove(points + 4 * i, points + 3 * i, 3 * sizeof *points);
            points[4 * i + 3] = 0.0;
        }
        options.stride = 4 * sizeof *points;
        options.backend = NULL;
        pbw_triangulate(3, points, NULL, count, &options, &a);
        options.backend = pbw_cuda_backend(0);
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &b), PBW_OK);
        CHECK(b.statistics.by_backend && meshes_equal(&a, &b));
        pbw_free(&a);
        pbw_free(&b);
        test_end();
    }
    free(points);
    free(floats);
}

static int stop_at_once(void *user, pbw_stage stage, double done)
{
    (void)user;
    (void)done;
    return stage == PBW_STAGE_BUILD;
}

static void *no_more(void *user, void *block, size_t old_size, size_t new_size)
{
    size_t *left = (size_t *)user;
    (void)old_size;
    if (new_size == 0) {
        free(block);
        return NULL;
    }
    if (new_size > *left) {
        return NULL;
    }
    *left -= new_size;
    return realloc(block, new_size);
}

static void test_failures(void)
{
    const size_t count = 50000;
    double *points = (double *)malloc(count * 3 * sizeof *points);
    char message[256] = "";
    pbw_options options;
    pbw_mesh mesh;
    input_fill(INPUT_UNIFORM, 3, count, 1, points);
    memset(&options, 0, sizeof options);
    options.message = message;
    options.message_size = sizeof message;
    if (test_begin("no such device")) {
        CHECK(pbw_cuda_backend(-1) == NULL);
        options.backend = pbw_cuda_backend(7);
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_ERROR_BACKEND);
        CHECK(message[0] != '\0' && meshes_is_empty(&mesh));
        options.flags = PBW_BACKEND_OR_CPU;
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_OK);
        CHECK(!mesh.statistics.by_backend);
        pbw_free(&mesh);
        options.flags = 0;
        test_end();
    }
    options.backend = pbw_cuda_backend(0);
    if (test_begin("cancelled")) {
        options.progress = stop_at_once;
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_CANCELLED);
        CHECK(meshes_is_empty(&mesh));
        options.progress = NULL;
        test_end();
    }
    if (test_begin("out of memory on the host")) {
        size_t left;
        for (left = 1000; left < 30000000; left = left * 3 / 2) {
            size_t available = left;
            pbw_status status;
            options.resize = no_more;
            options.resize_user = &available;
            status = pbw_triangulate(3, points, NULL, count, &options, &mesh);
            CHECK(status == PBW_OK || (status == PBW_ERROR_MEMORY && meshes_is_empty(&mesh)));
            pbw_free(&mesh);
        }
        test_end();
    }
    if (test_begin("not finite")) {
        options.resize = NULL;
        points[77] = HUGE_VAL;
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_ERROR_NOT_FINITE);
        CHECK(meshes_is_empty(&mesh));
        test_end();
    }
    free(points);
}

int main(int argc, char **argv)
{
    static const double cube[3 * 8] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 1, 1 };
    char message[256] = "";
    pbw_options options;
    pbw_mesh mesh;
    test_start(argc, argv, 300);
    memset(&options, 0, sizeof options);
    options.backend = pbw_cuda_backend(0);
    options.message = message;
    options.message_size = sizeof message;
    if (pbw_triangulate(3, cube, NULL, 8, &options, &mesh) == PBW_ERROR_BACKEND) {
        printf("skipped: %s\n0 passed, 0 failed, 1 skipped\n", message);
        return 0;
    }
    pbw_free(&mesh);
    test_zoo();
    test_random();
    test_kinds(20000);
    test_forms();
    test_failures();
    printf("%ld builds by the GPU, %ld left to the CPU\n", by_gpu, by_cpu);
    return test_finish();
}
