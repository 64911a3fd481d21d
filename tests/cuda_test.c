/* cuda_test.c: pbw_cuda.cu against the CPU, byte for byte: the zoo, and all kinds of points and weights at sizes that
   reach every rung, each by one device and by a team of 2 to 16, the devices there are in turn.  Linked with a
   pbw_cuda.cu that was compiled for few points too (PBW_CUDA_FEW).  Some tests take nearly all of a device's memory: not
   for two programs at once on one device. */
#define _POSIX_C_SOURCE 200112L
#define PBW_IMPLEMENTATION
#define PBW_CUDA
#define PBW_CHECK_IMPLEMENTATION
#include "pbw_check.h"
#include "test.h"
#include "meshes.h"
#include <cuda_runtime_api.h>
#include <time.h>

extern int pbw_cuda_by_host, pbw_cuda_patient;  /* of a pbw_cuda.cu compiled for tests */
extern long pbw_cuda_fail_at;
extern size_t pbw_cuda_piece;

static long by_gpu, by_cpu;                     /* builds of PBW_OK, by who made them */
static int leaves_memory;                       /* CUDA_TEST_LEAVE, for initcheck: device memory is not filled */
static size_t fewer = 1;                        /* CUDA_TEST_FEWER, for racecheck: divides the points of large tests, and
                                                   the builds of tests that try one limit after another */

cudaError_t __real_cudaHostAlloc(void **block, size_t bytes, unsigned flags);
cudaError_t __wrap_cudaHostAlloc(void **block, size_t bytes, unsigned flags);

/* With no_pinned there is no pinned memory. */
static int no_pinned;
cudaError_t __wrap_cudaHostAlloc(void **block, size_t bytes, unsigned flags)
{
    return no_pinned ? cudaErrorMemoryAllocation : __real_cudaHostAlloc(block, bytes, flags);
}

cudaError_t __real_cudaMallocFromPoolAsync(void **block, size_t bytes, cudaMemPool_t pool, cudaStream_t stream);
cudaError_t __wrap_cudaMallocFromPoolAsync(void **block, size_t bytes, cudaMemPool_t pool, cudaStream_t stream);

/* The linker's --wrap makes pbw_cuda.cu call this.  It fills each block with a byte of its own, so a build that reads
   what it has not written differs from that of the CPU. */
cudaError_t __wrap_cudaMallocFromPoolAsync(void **block, size_t bytes, cudaMemPool_t pool, cudaStream_t stream)
{
    static int blocks;
    const cudaError_t error = __real_cudaMallocFromPoolAsync(block, bytes, pool, stream);
    const int byte = __sync_add_and_fetch(&blocks, 1) * 151 & 255;
    return error != cudaSuccess || leaves_memory ? error : cudaMemsetAsync(*block, byte, bytes, stream);
}

static const pbw_backend *team_of(int cards)
{
    int device[16], devices = 1, i;
    CHECK(cudaGetDeviceCount(&devices) == cudaSuccess && cards <= 16);
    for (i = 0; i < cards; i++) {
        device[i] = i % devices;
    }
    return pbw_cuda_backend_multi(device, cards);
}

/* There for all streams: cudaMemcpy may return while the last bytes are still on their way. */
static void *to_device(const void *from, size_t bytes)
{
    void *block = NULL;
    CHECK(cudaMalloc(&block, bytes > 0 ? bytes : 1) == cudaSuccess
          && cudaMemcpy(block, from, bytes, cudaMemcpyHostToDevice) == cudaSuccess
          && cudaDeviceSynchronize() == cudaSuccess);
    return block;
}

static pbw_index *from_device(const pbw_index *from, size_t count)
{
    pbw_index *block = from == NULL ? NULL : (pbw_index *)zoo_grow(NULL, (count + 1) * sizeof *block);
    CHECK(block == NULL || cudaMemcpy(block, from, count * sizeof *block, cudaMemcpyDeviceToHost) == cudaSuccess);
    return block;
}

/* 1 if the arrays on the device are those of the CPU. */
static int same_mesh(const pbw_mesh *cpu, const pbw_cuda_mesh *mesh)
{
    const size_t links = mesh->simplex_count * ((size_t)mesh->dim + 1), count = mesh->point_count;
    pbw_mesh copy = *cpu;
    pbw_index *simplices = from_device(mesh->simplices, links), *neighbors = from_device(mesh->neighbors, links);
    pbw_index *incident = from_device(mesh->incident, count), *canonical = from_device(mesh->canonical, count);
    int same;
    copy.dim = mesh->dim;
    copy.point_count = mesh->point_count;
    copy.simplex_count = mesh->simplex_count;
    copy.duplicate_count = mesh->duplicate_count;
    copy.hidden_count = mesh->hidden_count;
    copy.simplices = simplices;
    copy.neighbors = neighbors;
    copy.incident = incident;
    copy.canonical = canonical;
    same = meshes_equal(cpu, &copy);
    free(simplices);
    free(neighbors);
    free(incident);
    free(canonical);
    return same;
}

/* The status of pbw_cuda_triangulate for points on the device, in a stream of their own; on success its mesh must be
   that of the CPU, elsewhere empty.  by: the CPU that it may be left to, or NULL; by_host: whether it was. */
static pbw_status on_device(const pbw_mesh *cpu, int dim, int is_float, const void *points, const void *weights,
                            size_t count, const pbw_options *options, pbw_triangulator *by, int *by_host)
{
    const size_t size = is_float ? sizeof(float) : sizeof(double);
    void *there = to_device(points, count * (size_t)dim * size);
    void *weights_there = weights == NULL ? NULL : to_device(weights, count * size);
    cudaStream_t stream;
    pbw_cuda_mesh mesh, none;
    pbw_status status;
    memset(&none, 0, sizeof none);
    memset(&mesh, 1, sizeof mesh);
    CHECK(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking) == cudaSuccess);
    status = pbw_cuda_triangulate(dim, is_float, there, weights_there, count, options, stream, by, &mesh);
    CHECK(cudaStreamSynchronize(stream) == cudaSuccess);
    *by_host = mesh.by_cpu;
    if (status == PBW_OK || status == PBW_DEGENERATE) {
        if (!CHECK(same_mesh(cpu, &mesh))) {
            test_say("on the device, %s", mesh.by_cpu ? "by the CPU" : "by the GPU");
        }
        pbw_cuda_free(&mesh, stream);
    }
    CHECK(memcmp(&mesh, &none, sizeof none) == 0);
    CHECK(cudaStreamDestroy(stream) == cudaSuccess);
    cudaFree(there);
    cudaFree(weights_there);
    return status;
}

/* All builds of one input, and the comparison. */
static void compare(int dim, const double *points, const double *weights, size_t count, unsigned flags)
{
    pbw_mesh cpu, gpu;
    pbw_options options;
    pbw_status expected, status;
    char message[256] = "";
    static const int teams[6] = { 1, 2, 3, 4, 7, 16 };
    int i, alone = 0, by_host = 0;
    memset(&options, 0, sizeof options);
    options.flags = flags;
    expected = pbw_triangulate(dim, points, weights, count, &options, &cpu);
    options.message = message;
    options.message_size = sizeof message;
    status = on_device(&cpu, dim, 0, points, weights, count, &options, pbw_triangulate, &by_host);
    if (!CHECK_EQUAL(status, expected)) {
        test_say("on the device: %s", message);
    }
    for (i = 0; i < (count < 1000 ? 6 : 2); i++) {
        int cards = teams[i == 0 || count < 1000 ? i : 1 + (by_gpu + by_cpu) % 5];
        options.backend = i == 0 ? pbw_cuda_backend(0) : team_of(cards);
        status = pbw_triangulate(dim, points, weights, count, &options, &gpu);
        if (!CHECK_EQUAL(status, expected)) {
            test_say("%d cards: %s", cards, message);
        }
        if (status == expected && (status == PBW_OK || status == PBW_DEGENERATE)) {
            if (!CHECK(meshes_equal(&cpu, &gpu))) {
                test_say("%d cards", cards);
            }
            if (i == 0) {
                alone = gpu.statistics.by_backend;
                CHECK_EQUAL(by_host, !alone);
                by_gpu += status == PBW_OK && alone;
                by_cpu += status == PBW_OK && !alone;
            } else if (alone && !CHECK(gpu.statistics.by_backend         /* a share's sample may decline */
                                       || (!pbw_cuda_patient && strncmp(message, "most stars", 10) == 0))) {
                test_say("%d cards: %s", cards, message);
            }
        }
        pbw_free(&gpu);
    }
    pbw_free(&cpu);
}

/* Without pinned memory, which is not pinned before: the driver copies. */
static void test_no_pinned(void)
{
    double points[3 * 2000];
    if (test_begin("no pinned memory")) {
        input_fill(INPUT_UNIFORM, 3, 2000, (uint64_t)test_seed, points);
        no_pinned = 1;
        compare(3, points, NULL, 2000, 0);
        no_pinned = 0;
        compare(3, points, NULL, 2000, 0);
        test_end();
    }
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
    for (i = 1; i <= test_count; i++) {
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
        if (test_begin("random points on grids, set %ld", i)) {
            compare(dim, points, weighted ? weights : NULL, count, 0);
            test_end();
        }
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
    if (test_begin("floats on the device")) {
        int by_host = 1;
        pbw_triangulatef(3, floats, NULL, count, NULL, &a);
        CHECK_EQUAL(on_device(&a, 3, 1, floats, NULL, count, NULL, pbw_triangulate, &by_host), PBW_OK);
        CHECK(!by_host);
        pbw_free(&a);
        pbw_triangulatef(2, floats, floats + 4, 7, NULL, &a);
        CHECK_EQUAL(on_device(&a, 2, 1, floats, floats + 4, 7, NULL, pbw_triangulate, &by_host), PBW_OK);
        CHECK(by_host);
        pbw_free(&a);
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
        options.backend = team_of(2);
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &b), PBW_OK);
        CHECK(b.statistics.by_backend && meshes_equal(&a, &b));
        pbw_free(&a);
        pbw_free(&b);
        test_end();
    }
    free(points);
    free(floats);
}

/* ---- pbw_cuda_check against pbw_check, on good meshes and on planted faults */
/* 1 if both say the same of a mesh, and that is good or not as expected. */
static int checks_agree(const pbw_mesh *mesh, int good)
{
    const size_t each = mesh->point_count * sizeof(pbw_index);
    const size_t links = mesh->simplex_count * ((size_t)mesh->dim + 1) * sizeof(pbw_index);
    pbw_report cpu, gpu;
    pbw_cuda_mesh copy;
    char message[256] = "";
    pbw_options options;
    int same;
    void *points = to_device(mesh->points, mesh->point_count * (size_t)mesh->dim * sizeof(double));
    void *weights = mesh->weights == NULL ? NULL : to_device(mesh->weights, mesh->point_count * sizeof(double));
    memset(&options, 0, sizeof options);
    options.message = message;
    options.message_size = sizeof message;
    memset(&copy, 0, sizeof copy);
    copy.dim = mesh->dim;
    copy.point_count = mesh->point_count;
    copy.simplex_count = mesh->simplex_count;
    copy.duplicate_count = mesh->duplicate_count;
    copy.hidden_count = mesh->hidden_count;
    copy.simplices = (pbw_index *)to_device(mesh->simplices, links);
    copy.neighbors = (pbw_index *)to_device(mesh->neighbors, links);
    copy.incident = (pbw_index *)to_device(mesh->incident, each);
    copy.canonical = (pbw_index *)to_device(mesh->canonical, each);
    CHECK_EQUAL(pbw_check(mesh, NULL, &cpu), PBW_OK);
    if (!CHECK_EQUAL(pbw_cuda_check(&copy, 0, points, weights, &options, NULL, &gpu), PBW_OK)) {
        test_say("%s", message);
    }
    same = cpu.valid == gpu.valid && strcmp(cpu.what, gpu.what) == 0 && cpu.simplex == gpu.simplex
        && cpu.facet == gpu.facet && cpu.point == gpu.point && gpu.valid == good
        && (!good || (cpu.vertex_count == gpu.vertex_count && cpu.facet_count == gpu.facet_count
                      && cpu.hull_facet_count == gpu.hull_facet_count));
    if (!same) {
        test_say("CPU: %s, %ld %ld %ld; GPU: %s, %ld %ld %ld; good is %d", cpu.what, (long)cpu.simplex,
                 (long)cpu.facet, (long)cpu.point, gpu.what, (long)gpu.simplex, (long)gpu.facet, (long)gpu.point,
                 good);
    }
    cudaFree(copy.simplices);
    cudaFree(copy.neighbors);
    cudaFree(copy.incident);
    cudaFree(copy.canonical);
    cudaFree(points);
    cudaFree(weights);
    return same;
}

/* A fault in a copy of an array, for as long as it is checked. */
static int finds(pbw_mesh *mesh, const pbw_index **array, size_t length, size_t at, pbw_index value)
{
    const pbw_index *whole = *array;
    pbw_index *copy = (pbw_index *)zoo_grow(NULL, length * sizeof *copy);
    int found;
    memcpy(copy, whole, length * sizeof *copy);
    copy[at] = value;
    *array = copy;
    found = checks_agree(mesh, 0);
    *array = whole;
    free(copy);
    return found;
}

static void plant_faults(pbw_mesh *mesh, uint64_t *state)
{
    const size_t corners = (size_t)mesh->dim + 1, links = mesh->simplex_count * corners, n = mesh->point_count;
    const double *whole = mesh->points;
    double *moved = (double *)zoo_grow(NULL, n * (size_t)mesh->dim * sizeof *moved);
    int i;
    for (i = 0; i < 4; i++) {
        size_t s = input_below(state, (uint32_t)mesh->simplex_count) * corners;
        size_t k = input_below(state, (uint32_t)mesh->dim);
        size_t other = input_below(state, (uint32_t)mesh->simplex_count), p = mesh->simplices[s];
        pbw_index *swapped = (pbw_index *)zoo_grow(NULL, links * sizeof *swapped);
        const pbw_index *simplices = mesh->simplices;
        memcpy(swapped, simplices, links * sizeof *swapped);
        swapped[s + k] = simplices[s + k + 1];
        swapped[s + k + 1] = simplices[s + k];
        mesh->simplices = swapped;
        CHECK(checks_agree(mesh, 0));
        mesh->simplices = simplices;
        free(swapped);
        CHECK(finds(mesh, &mesh->simplices, links, s + k, (pbw_index)n));
        CHECK(finds(mesh, &mesh->neighbors, links, s + k, mesh->neighbors[s + k] == PBW_NONE ? 0 : PBW_NONE));
        CHECK(finds(mesh, &mesh->neighbors, links, s + k,
                    mesh->neighbors[s + k] == other ? (pbw_index)(other == 0) : (pbw_index)other));
        CHECK(finds(mesh, &mesh->incident, n, p, (pbw_index)mesh->simplex_count));
        CHECK(finds(mesh, &mesh->canonical, n, p, (pbw_index)(p == 0)));
        memcpy(moved, whole, n * (size_t)mesh->dim * sizeof *moved);
        moved[p * (size_t)mesh->dim] += 10.0 * (1.0 + fabs(moved[p * (size_t)mesh->dim]));
        mesh->points = moved;
        CHECK(checks_agree(mesh, 0));
        mesh->points = whole;
    }
    mesh->hidden_count++;
    CHECK(checks_agree(mesh, 0));
    mesh->hidden_count--;
    free(moved);
}

/* The regular triangulation for one weight that is not 0, taken for the Delaunay triangulation: sound in all but the
   flips around one point. */
static void test_flipped(int dim, int kind, size_t n)
{
    double *points = (double *)zoo_grow(NULL, n * 3 * sizeof *points);
    double *weights = (double *)zoo_grow(NULL, n * sizeof *weights), weight;
    pbw_mesh plain, mesh;
    input_fill(kind, dim, n, (uint64_t)test_seed, points);
    memset(weights, 0, n * sizeof *weights);
    CHECK_EQUAL(pbw_triangulate(dim, points, NULL, n, NULL, &plain), PBW_OK);
    for (weight = 1e-9; weight < 1e9; weight *= 2.0) {
        int differs;
        weights[n / 2] = weight;
        CHECK_EQUAL(pbw_triangulate(dim, points, weights, n, NULL, &mesh), PBW_OK);
        differs = mesh.simplex_count != plain.simplex_count
               || memcmp(mesh.simplices, plain.simplices,
                         mesh.simplex_count * ((size_t)dim + 1) * sizeof(pbw_index)) != 0;
        if (differs) {
            const double *own = mesh.weights;
            CHECK(checks_agree(&mesh, 1));
            mesh.weights = NULL;
            CHECK(checks_agree(&mesh, 0));
            mesh.weights = own;
        }
        pbw_free(&mesh);
        if (differs) {
            break;
        }
    }
    CHECK(weight < 1e9);
    pbw_free(&plain);
    free(points);
    free(weights);
}

static void test_verdicts(size_t count)
{
    uint64_t state = test_seed;
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points);
    double *weights = (double *)zoo_grow(NULL, count * sizeof *weights);
    int dim, kind, weighted;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            for (weighted = 0; weighted < 2; weighted++) {
                size_t n = kind == INPUT_MOMENT ? 200 : count;
                pbw_mesh mesh;
                if (!test_begin("check: %dD %s%s", dim, input_name(kind), weighted ? " weighted" : "")) {
                    continue;
                }
                input_fill(kind, dim, n, (uint64_t)test_seed, points);
                input_fill_weights(INPUT_WEIGHTS_HIDING, dim, n, (uint64_t)test_seed, points, weights);
                memcpy(points, points + (size_t)dim * (n - 1), (size_t)dim * sizeof *points);   /* a duplicate */
                CHECK_EQUAL(pbw_triangulate(dim, points, weighted ? weights : NULL, n, NULL, &mesh), PBW_OK);
                CHECK(mesh.duplicate_count > 0);
                CHECK(checks_agree(&mesh, 1));
                if (kind == INPUT_UNIFORM || kind == INPUT_LATTICE || kind == INPUT_MOMENT) {
                    plant_faults(&mesh, &state);
                }
                pbw_free(&mesh);
                test_end();
            }
        }
        for (kind = 0; kind < 2; kind++) {
            if (test_begin("check: %dD flipped facets, %s", dim, kind == 0 ? "uniform" : "lattice")) {
                test_flipped(dim, kind == 0 ? INPUT_UNIFORM : INPUT_LATTICE, 2000);
                test_end();
            }
        }
    }
    free(points);
    free(weights);
}

static int stop_at_once(void *user, pbw_stage stage, double done)
{
    (void)user;
    (void)done;
    return stage == PBW_STAGE_BUILD;
}

static long calls, stop_at;                     /* of progress */

static int stop_later(void *user, pbw_stage stage, double done)
{
    (void)user;
    (void)stage;
    (void)done;
    return ++calls >= stop_at;
}

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

typedef struct alarm_clock { double rings, rang; } alarm_clock;

static int stop_when_it_rings(void *user, pbw_stage stage, double done)
{
    alarm_clock *a = (alarm_clock *)user;
    (void)stage;
    (void)done;
    if (a->rang == 0.0 && seconds() >= a->rings) {
        a->rang = seconds();
    }
    return a->rang != 0.0;
}

/* Seconds from a cancellation that comes so late to the end of its build; 0 if the build ended first. */
static double cancelled_for(const double *points, size_t count, double late)
{
    alarm_clock a = { 0.0, 0.0 };
    pbw_options options;
    pbw_status status;
    pbw_mesh mesh;
    double took;
    memset(&options, 0, sizeof options);
    options.backend = pbw_cuda_backend(0);
    options.progress = stop_when_it_rings;
    options.progress_user = &a;
    a.rings = seconds() + late;
    status = pbw_triangulate(3, points, NULL, count, &options, &mesh);
    took = a.rang != 0.0 ? seconds() - a.rang : 0.0;
    CHECK_EQUAL(status, a.rang != 0.0 ? PBW_CANCELLED : PBW_OK);
    pbw_free(&mesh);
    return took;
}

/* Whether others want this processor, too: they have a fifth of 50 ms or more. */
static int is_busy(void)
{
    const double began = seconds();
    const clock_t before = clock();
    while (seconds() - began < 0.05) { }
    return (double)(clock() - before) / CLOCKS_PER_SEC < 0.8 * (seconds() - began);
}

/* A cancelled build returns soon, whatever the device is at.  A late one counts unless the machine is busy. */
static void test_soon(void)
{
    const size_t count = 4000000;
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points), worst = 0.0, all = 0.0, took, began;
    pbw_options options;
    pbw_mesh mesh;
    int i, tries;
    input_fill(INPUT_UNIFORM, 3, count, 1, points);
    memset(&options, 0, sizeof options);
    options.backend = pbw_cuda_backend(0);
    for (i = 0; i < 2; i++) {
        began = seconds();
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_OK);
        pbw_free(&mesh);
        all = seconds() - began;
    }
    for (i = 1; i < 12; i++) {
        tries = 0;
        do {
            took = cancelled_for(points, count, all * i / 12.0);
        } while (took >= 0.5 * all && is_busy() && ++tries < 5);
        worst = took > worst ? took : worst;
    }
    printf("cancelled after %.1f ms at most, of a build of %.1f ms\n", 1e3 * worst, 1e3 * all);
    CHECK(worst < 0.5 * all);                        /* relative: a busy machine slows both */
    free(points);
}

/* Sizes beyond what one card has: as much memory as makes one refuse, and say what it needs, is enough for a team,
   whose mesh is that of the CPU.  by_cards: the memory is that of the devices, else options.memory_limit. */
static void test_beyond(size_t count, int by_cards, int cards)
{
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points);
    void *taken[16] = { NULL };
    char message[256] = "";
    pbw_options options;
    pbw_mesh cpu, gpu;
    size_t needed = 0, said = 0, available, all;
    int i;
    input_fill(INPUT_UNIFORM, 3, count, 1, points);
    memset(&options, 0, sizeof options);
    CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &cpu), PBW_OK);
    options.message = message;
    options.message_size = sizeof message;
    for (i = 0; by_cards && i < cards; i++) {
        CHECK(cudaSetDevice(i) == cudaSuccess && cudaDeviceSynchronize() == cudaSuccess);
        CHECK(cudaMemGetInfo(&available, &all) == cudaSuccess && available > count * 460
              && cudaMalloc(&taken[i], available - count * 460) == cudaSuccess);
    }
    options.memory_limit = by_cards ? 0 : count * 460;
    options.backend = pbw_cuda_backend(0);
    CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &gpu), PBW_ERROR_BACKEND);
    if (!CHECK(sscanf(message, "too little device memory: %zu bytes are needed, %zu are available", &needed, &said)
               == 2 && needed > said && meshes_is_empty(&gpu))) {
        test_say("%s", message);
    }
    options.backend = team_of(cards);
    message[0] = '\0';
    if (!CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &gpu), PBW_OK)
        || !CHECK(gpu.statistics.by_backend && meshes_equal(&cpu, &gpu))) {
        test_say("%s", message);
    }
    pbw_free(&gpu);
    pbw_free(&cpu);
    for (i = 0; by_cards && i < cards; i++) {
        cudaSetDevice(i);
        cudaFree(taken[i]);
    }
    cudaSetDevice(0);
    free(points);
}

/* Points on lines and on a sphere are left to the CPU before much is done; others are not. */
static void test_declined(void)
{
    const size_t count = 50000;
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points);
    char message[256] = "";
    pbw_options options;
    pbw_mesh cpu, gpu;
    int kind, cards;
    memset(&options, 0, sizeof options);
    options.message = message;
    options.message_size = sizeof message;
    for (kind = 0; kind < INPUT_KINDS && kind != INPUT_MOMENT; kind++) {
        int reaches_far = kind == INPUT_LINES || kind == INPUT_SPHERE;
        int stays_near = kind == INPUT_TERRAIN || kind == INPUT_UNIFORM || kind == INPUT_GAUSS || kind == INPUT_BALL
                      || kind == INPUT_LATTICE;
        if (!reaches_far && !stays_near) {
            continue;
        }
        if (test_begin("declined early: %s", input_name(kind))) {
            input_fill(kind, 3, count, (uint64_t)test_seed, points);
            CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, NULL, &cpu), PBW_OK);
            pbw_cuda_patient = 0;
            for (cards = 1; cards <= 2; cards++) {
                options.backend = team_of(cards);
                message[0] = '\0';
                CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &gpu), PBW_OK);
                if (!CHECK(gpu.statistics.by_backend == stays_near && meshes_equal(&cpu, &gpu)
                           && (stays_near || strncmp(message, "most stars reach far", 20) == 0)
                           && (kind != INPUT_SPHERE || strstr(message, "on a sphere") != NULL))) {
                    test_say("%s", message);
                }
                pbw_free(&gpu);
            }
            pbw_cuda_patient = 1;
            pbw_free(&cpu);
            test_end();
        }
    }
    if (test_begin("declined early: a shell")) {     /* a noisy sphere: large stars, which show only when built */
        const size_t many = 200000;
        uint64_t state = test_seed;
        size_t i;
        points = (double *)zoo_grow(points, many * 3 * sizeof *points);
        input_fill(INPUT_SPHERE, 3, many, (uint64_t)test_seed, points);
        for (i = 0; i < 3 * many; i += 3) {
            const double by = 1.0 + 0.02 * (input_uniform(&state) - 0.5);
            points[i] *= by;
            points[i + 1] *= by;
            points[i + 2] *= by;
        }
        pbw_cuda_patient = 0;
        options.backend = team_of(1);
        message[0] = '\0';
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, many, &options, &gpu), PBW_OK);
        CHECK(gpu.statistics.by_backend == 0 && strstr(message, "on a sphere") != NULL);
        pbw_free(&gpu);
        pbw_cuda_patient = 1;
        test_end();
    }
    free(points);
}

/* Points on a sphere, rounded, and nearly on it: whoever builds them, the mesh is the same. */
static void test_spheres(void)
{
    enum { plain, apart, twice, some_off, a_part, floats, forms };
    static const char *const names[forms] = { "", ", far from 0", ", many twice", ", some elsewhere",
                                              ", a part of it", ", floats" };
    static const double noises[4] = { 0.0, 1e-12, 1e-8, 1e-6 };
    const size_t most = 60000;
    double *points = (double *)zoo_grow(NULL, most * 3 * sizeof *points);
    size_t count, i, k;
    int form, noise;
    for (count = 2000 / fewer; count <= most / fewer; count *= 5) {
        for (form = 0; form < forms; form++) {
            for (noise = 0; noise < (form == plain ? 4 : 1); noise++) {
                uint64_t state = test_seed;
                if (!test_begin("%lu points on a sphere%s, noise %g", (unsigned long)count, names[form],
                                noises[noise])) {
                    continue;
                }
                input_fill(INPUT_SPHERE, 3, count, (uint64_t)test_seed, points);
                for (i = 0; i < count; i++) {
                    double *p = points + 3 * i, length = 0.0, off = noises[noise] * (input_uniform(&state) - 0.5);
                    p[2] = form == a_part ? 4.0 + fabs(p[2]) : p[2];
                    for (k = 0; k < 3; k++) {
                        length += p[k] * p[k];
                    }
                    for (k = 0; k < 3; k++) {
                        p[k] *= form == a_part ? 1.0 / sqrt(length) : 1.0 + off;
                        p[k] = form == apart ? 1000.3 * (double)(k + 1) + 7.0 * p[k] : p[k];
                        p[k] = form == floats ? (double)(float)p[k] : p[k];
                        p[k] *= form == some_off && i % 1000 == 7 ? (i % 2000 == 7 ? 0.5 : 1.5) : 1.0;
                        p[k] = form == twice && i % 3 == 1 ? p[(long)k - 3] : p[k];
                    }
                }
                pbw_cuda_patient = 0;
                compare(3, points, NULL, count, 0);
                pbw_cuda_patient = 1;
                test_end();
            }
        }
    }
    free(points);
}

/* Points on surfaces: noisy, rounded, repeated; and all kinds as a sample of them finds them. */
static void test_surfaces(void)
{
    enum { terrain, torus, scan, shell, sheets, on_grid, forms };
    static const char *const names[forms] = { "terrain", "a torus, some twice", "a scan in floats", "a noisy sphere",
                                              "two sheets", "a torus on a grid" };
    const size_t most = 120000;
    double *points = (double *)zoo_grow(NULL, most * 3 * sizeof *points);
    size_t count, i, k;
    int form, kind;
    pbw_cuda_patient = 0;
    for (count = 20000 / fewer; count <= (fewer > 1 ? 2000 : most); count *= fewer > 1 ? 2 : 6) {
        for (form = 0; form < forms; form++) {
            uint64_t state = test_seed;
            long before = by_gpu;
            if (!test_begin("%lu points on %s", (unsigned long)count, names[form])) {
                continue;
            }
            input_fill(form == terrain || form == sheets ? INPUT_TERRAIN : INPUT_SPHERE, 3, count,
                       (uint64_t)test_seed, points);
            for (i = 0; i < count && form != terrain; i++) {
                double *p = points + 3 * i, c, s, x, y, radius;
                input_turn(input_uniform(&state), &c, &s);
                input_turn(input_uniform(&state), &x, &y);
                if (form == sheets) {
                    p[2] += i % 2 == 0 ? 700.0 : 0.0;
                } else if (form == torus || form == on_grid) {
                    p[0] = (1.0 + 0.4 * x) * c;
                    p[1] = (1.0 + 0.4 * x) * s;
                    p[2] = 0.4 * y + (form == torus ? 1e-4 * input_gauss(&state) : 0.0);
                } else {
                    radius = form == shell ? 1.0 : 1.0 + 0.2 * p[0] * p[1] + 0.3 * p[2] * p[2] * p[0];
                    for (k = 0; k < 3; k++) {
                        p[k] *= radius * (1.0 + (form == shell ? 1e-3 : 1e-4) * input_gauss(&state));
                    }
                }
                for (k = 0; k < 3; k++) {
                    p[k] = form == scan ? (double)(float)p[k] : p[k];
                    p[k] = form == on_grid ? floor(p[k] * 4096.0) / 4096.0 : p[k];
                    p[k] = form == torus && i % 3 == 1 ? p[(long)k - 3] : p[k];
                }
            }
            compare(3, points, NULL, count, 0);
            CHECK(form == on_grid || by_gpu > before || fewer > 1);
            test_end();
        }
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            if (kind != INPUT_MOMENT
                && test_begin("%lu points, sampled: %s", (unsigned long)count, input_name(kind))) {
                input_fill(kind, 3, count, (uint64_t)test_seed, points);
                compare(3, points, NULL, count, 0);
                test_end();
            }
        }
    }
    pbw_cuda_patient = 1;
    free(points);
}

static void test_teams(void)
{
    int devices = 1, cards, dim, kind;
    double *points = (double *)zoo_grow(NULL, 20000 * 3 * sizeof *points);
    cudaGetDeviceCount(&devices);
    for (cards = 2; cards <= 4; cards++) {
        if (test_begin("more than one card holds, %d cards", cards)) {
            test_beyond(fewer > 1 ? 50000 : 200000, 0, cards);
            test_end();
        }
        if (test_begin("more than one card has, %d cards", cards)) {
            if (devices < cards) {
                test_skip("too few devices");
            } else {
                test_beyond(2000000, 1, cards);
                test_end();
            }
        }
    }
    pbw_cuda_by_host = 1;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            if (test_begin("cards that cannot reach each other: %dD %s", dim, input_name(kind))) {
                const size_t count = kind == INPUT_MOMENT ? 200 : 20000 / fewer;
                input_fill(kind, dim, count, 1, points);
                compare(dim, points, NULL, count, 0);
                test_end();
            }
        }
    }
    pbw_cuda_by_host = 0;
    free(points);
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

/* A build that is cancelled later and later, until it is not. */
static void cancel_later(const double *points, size_t count, pbw_options options)
{
    pbw_status status = PBW_CANCELLED;
    options.progress = stop_later;
    for (stop_at = 1; status == PBW_CANCELLED; stop_at = 2 * (long)fewer * stop_at + 1) {
        pbw_mesh mesh;
        calls = 0;
        status = pbw_triangulate(3, points, NULL, count, &options, &mesh);
        CHECK_EQUAL(status, calls >= stop_at ? PBW_CANCELLED : PBW_OK);
        CHECK(status == PBW_OK || meshes_is_empty(&mesh));
        pbw_free(&mesh);
    }
}

/* What calls for points on the device say where they fail, and to whom they listen. */
static void test_failures_on_device(void)
{
    const size_t count = 50000;
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points);
    char message[256] = "";
    pbw_options options;
    pbw_mesh cpu, none;
    pbw_cuda_mesh mesh;
    size_t needed, said;
    int by_host = 0, kind;
    memset(&none, 0, sizeof none);
    memset(&options, 0, sizeof options);
    options.message = message;
    options.message_size = sizeof message;
    if (test_begin("on the device: arguments")) {
        double *there = (double *)to_device(points, 24);
        CHECK_EQUAL(pbw_cuda_triangulate(3, 0, there, NULL, 1, NULL, NULL, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_cuda_triangulate(4, 0, there, NULL, 1, NULL, NULL, NULL, &mesh), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_cuda_triangulate(3, 0, NULL, NULL, 1, NULL, NULL, NULL, &mesh), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_cuda_triangulate(3, 0, there, NULL, PBW_NONE, NULL, NULL, NULL, &mesh),
                    PBW_ERROR_TOO_LARGE);
        options.flags = 8;
        CHECK_EQUAL(pbw_cuda_triangulate(3, 0, there, NULL, 1, &options, NULL, NULL, &mesh), PBW_ERROR_ARGUMENT);
        options.flags = 0;
        options.stride = 32;
        CHECK_EQUAL(pbw_cuda_triangulate(3, 0, there, NULL, 1, &options, NULL, NULL, &mesh), PBW_ERROR_ARGUMENT);
        options.stride = 24;
        CHECK_EQUAL(pbw_cuda_triangulate(3, 0, there, NULL, 1, &options, NULL, NULL, &mesh), PBW_ERROR_BACKEND);
        CHECK(message[0] != '\0');
        CHECK_EQUAL(pbw_cuda_triangulate(3, 0, there, NULL, 1, &options, NULL, pbw_triangulate, &mesh),
                    PBW_DEGENERATE);
        pbw_cuda_free(&mesh, NULL);
        options.stride = 0;
        cudaFree(there);
        test_end();
    }
    if (test_begin("on the device: no points")) {
        pbw_triangulate(2, NULL, NULL, 0, NULL, &cpu);
        CHECK_EQUAL(on_device(&cpu, 2, 0, points, NULL, 0, &options, pbw_triangulate, &by_host), PBW_DEGENERATE);
        pbw_free(&cpu);
        test_end();
    }
    if (test_begin("on the device, without a CPU")) {
        pbw_cuda_patient = 0;
        for (kind = INPUT_UNIFORM; kind < INPUT_KINDS; kind++) {
            if (kind == INPUT_ANISOTROPIC || kind == INPUT_TERRAIN || kind == INPUT_LATTICE) {
                input_fill(kind, 3, 20000, 1, points);
                CHECK_EQUAL(pbw_triangulate(3, points, NULL, 20000, NULL, &cpu), PBW_OK);
                CHECK_EQUAL(on_device(&cpu, 3, 0, points, NULL, 20000, &options, NULL, &by_host), PBW_OK);
                CHECK(!by_host);
                pbw_free(&cpu);
            }
        }
        pbw_cuda_patient = 1;
        test_end();
    }
    for (kind = INPUT_UNIFORM; kind < INPUT_KINDS; kind += INPUT_LINES - INPUT_UNIFORM) {      /* GPU, then CPU */
        input_fill(kind, 3, count, 1, points);
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, NULL, &cpu), PBW_OK);
        pbw_cuda_patient = 0;
        if (test_begin("on the device, cancelled: %s", input_name(kind))) {
            pbw_status status = PBW_CANCELLED;
            options.progress = stop_later;
            for (stop_at = 1; status != PBW_OK; stop_at = 2 * (long)fewer * stop_at + 1) {
                calls = 0;
                status = on_device(&cpu, 3, 0, points, NULL, count, &options, pbw_triangulate, &by_host);
                CHECK_EQUAL(status, calls >= stop_at ? PBW_CANCELLED : PBW_OK);
                if (status != PBW_CANCELLED && status != PBW_OK) {
                    break;
                }
            }
            CHECK_EQUAL(by_host, kind != INPUT_UNIFORM);
            options.progress = NULL;
            test_end();
        }
        if (test_begin("on the device, out of memory on the host: %s", input_name(kind))) {
            size_t left;
            for (left = 1000; left < 100000000; left *= 2 * fewer) {
                size_t available = left;
                pbw_status status;
                options.resize = no_more;
                options.resize_user = &available;
                status = on_device(&cpu, 3, 0, points, NULL, count, &options, pbw_triangulate, &by_host);
                CHECK(status == PBW_OK || (status == PBW_ERROR_MEMORY && kind != INPUT_UNIFORM));
            }
            options.resize = NULL;
            test_end();
        }
        if (test_begin("on the device, memory limit: %s", input_name(kind))) {
            pbw_status status = PBW_ERROR_BACKEND;
            for (options.memory_limit = count * 20; status != PBW_OK && options.memory_limit < count * 4000;
                 options.memory_limit += options.memory_limit * fewer / 2) {
                status = on_device(&cpu, 3, 0, points, NULL, count, &options, pbw_triangulate, &by_host);
                CHECK(status == PBW_OK || status == PBW_ERROR_BACKEND
                      || (status == PBW_ERROR_MEMORY && kind != INPUT_UNIFORM));
            }
            CHECK_EQUAL(status, PBW_OK);
            if (kind == INPUT_UNIFORM) {
                options.memory_limit = count * 340;
                CHECK_EQUAL(on_device(&none, 3, 0, points, NULL, count, &options, pbw_triangulate, &by_host),
                            PBW_ERROR_BACKEND);
                CHECK(sscanf(message, "too little device memory: %zu bytes are needed, %zu are available", &needed,
                             &said) == 2 && said == options.memory_limit);
                options.flags = PBW_BACKEND_OR_CPU;
                CHECK_EQUAL(on_device(&cpu, 3, 0, points, NULL, count, &options, pbw_triangulate, &by_host), PBW_OK);
                CHECK(by_host);
                options.flags = 0;
            }
            options.memory_limit = 0;
            test_end();
        }
        pbw_cuda_patient = 1;
        pbw_free(&cpu);
    }
    if (test_begin("on the device: not finite")) {
        points[77] = HUGE_VAL;
        CHECK_EQUAL(on_device(&none, 3, 0, points, NULL, count, &options, pbw_triangulate, &by_host),
                    PBW_ERROR_NOT_FINITE);
        test_end();
    }
    free(points);
}

/* ---- points that move */
typedef struct walk {
    int dim;
    size_t count;
    double *points, *weights;                   /* weights NULL: none */
    pbw_options options;
    pbw_triangulator *cpu;
    pbw_cuda_loop *loop;
    cudaStream_t stream;
    char message[256];
} walk;

enum { broken, kept, whichever };

static void walk_start(walk *w, int dim, int kind, int weight_kind, size_t count)
{
    memset(w, 0, sizeof *w);
    w->dim = dim;
    w->count = count;
    w->points = (double *)zoo_grow(NULL, count * 3 * sizeof *w->points);
    input_fill(kind, dim, count, (uint64_t)test_seed, w->points);
    if (weight_kind >= 0) {
        w->weights = (double *)zoo_grow(NULL, count * sizeof *w->weights);
        input_fill_weights(weight_kind, dim, count, (uint64_t)test_seed, w->points, w->weights);
    }
    w->cpu = pbw_triangulate;
    w->options.message = w->message;
    w->options.message_size = sizeof w->message;
    CHECK(cudaStreamCreateWithFlags(&w->stream, cudaStreamNonBlocking) == cudaSuccess);
}

static void walk_end(walk *w)
{
    pbw_cuda_loop_free(w->loop);
    CHECK(cudaStreamDestroy(w->stream) == cudaSuccess);
    free(w->points);
    free(w->weights);
}

/* A step with the points where they are; its mesh is the CPU's or empty. */
static pbw_status walk_step(walk *w, int rebuild, int expected)
{
    void *there = to_device(w->points, w->count * (size_t)w->dim * sizeof(double));
    void *weights_there = w->weights == NULL ? NULL : to_device(w->weights, w->count * sizeof(double));
    pbw_cuda_points in;
    pbw_cuda_mesh mesh, none;
    pbw_mesh cpu;
    pbw_options options;
    pbw_status status;
    memset(&options, 0, sizeof options);
    memset(&none, 0, sizeof none);
    memset(&in, 0, sizeof in);
    memset(&mesh, 1, sizeof mesh);
    options.flags = w->options.flags & PBW_NO_NEIGHBORS;
    in.dim = w->dim;
    in.points = there;
    in.weights = weights_there;
    in.count = w->count;
    in.rebuild = rebuild;
    if (w->loop == NULL) {
        CHECK_EQUAL(pbw_cuda_loop_create(&w->options, w->stream, w->cpu, &w->loop), PBW_OK);
    }
    status = pbw_cuda_loop_step(w->loop, &in, &mesh);
    if (status == PBW_OK || status == PBW_DEGENERATE) {
        CHECK(cudaStreamSynchronize(w->stream) == cudaSuccess);
        CHECK_EQUAL(pbw_triangulate(w->dim, w->points, w->weights, w->count, &options, &cpu), status);
        CHECK(same_mesh(&cpu, &mesh));
        pbw_free(&cpu);
        if (!CHECK(expected == whichever || mesh.kept == expected)) {
            test_say("kept %d, by the CPU %d", mesh.kept, mesh.by_cpu);
        }
    } else {
        CHECK(memcmp(&mesh, &none, sizeof none) == 0);
    }
    cudaFree(there);
    cudaFree(weights_there);
    return status;
}

/* Multiplies all coordinates by a power of two, and the weights by its square. */
static void walk_scale(walk *w, double factor)
{
    size_t i;
    for (i = 0; i < w->count * (size_t)w->dim; i++) {
        w->points[i] *= factor;
    }
    for (i = 0; i < w->count && w->weights != NULL; i++) {
        w->weights[i] *= factor * factor;
    }
}

/* A quarter turn about the last axis: exact, but another order along the curve, and other ties. */
static void walk_turn(walk *w)
{
    size_t i;
    for (i = 0; i < w->count; i++) {
        double *p = w->points + i * (size_t)w->dim, x = p[0];
        p[0] = -p[1];
        p[1] = x;
    }
}

/* by: relative to the largest coordinate. */
static void walk_jitter(walk *w, double by)
{
    uint64_t state = test_seed + 1;
    double most = 0.0;
    size_t i;
    for (i = 0; i < w->count * (size_t)w->dim; i++) {
        most = fabs(w->points[i]) > most ? fabs(w->points[i]) : most;
    }
    for (i = 0; i < w->count * (size_t)w->dim; i++) {
        w->points[i] += by * most * (input_uniform(&state) - 0.5);
    }
}

/* Moves that keep the mesh and moves that break it, for sure or as it happens. */
static void test_walk(int dim, int kind, int weight_kind, size_t count)
{
    const int generic = kind == INPUT_UNIFORM || kind == INPUT_GAUSS || kind == INPUT_BALL;
    const size_t width = (size_t)dim * sizeof(double);
    double far[3] = { 0.0 };
    walk w;
    walk_start(&w, dim, kind, weight_kind, count);
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);
    walk_scale(&w, 4.0);
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);
    CHECK_EQUAL(walk_step(&w, 1, broken), PBW_OK);
    walk_turn(&w);
    CHECK_EQUAL(walk_step(&w, 0, generic ? kept : whichever), PBW_OK);
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);
    memcpy(far, w.points, width);                       /* two points change places */
    memcpy(w.points, w.points + (size_t)dim, width);
    memcpy(w.points + (size_t)dim, far, width);
    CHECK_EQUAL(walk_step(&w, 0, w.weights == NULL ? broken : whichever), PBW_OK);
    walk_jitter(&w, 1e-13);
    CHECK_EQUAL(walk_step(&w, 0, whichever), PBW_OK);
    memcpy(w.points, w.points + (size_t)dim, width);    /* a duplicate */
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);
    w.points[0] = 100.0 + 100.0 * fabs(w.points[1]);    /* beyond the hull */
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    walk_jitter(&w, 0.1);
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    w.count /= 2;
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    walk_end(&w);
}

/* Hidden points: they move and stay hidden, they come out, others go. */
static void test_walk_hidden(int dim)
{
    const size_t count = 3000;
    size_t i, hidden = count;
    walk w;
    pbw_mesh cpu;
    walk_start(&w, dim, INPUT_UNIFORM, INPUT_WEIGHTS_HALF, count);
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    CHECK_EQUAL(pbw_triangulate(dim, w.points, w.weights, count, NULL, &cpu), PBW_OK);
    for (i = 0; i < count; i++) {
        if (cpu.incident[i] == PBW_NONE && (hidden == count || w.weights[i] < w.weights[hidden])) {
            hidden = i;
        }
    }
    CHECK(hidden < count && cpu.hidden_count > count / 10);
    pbw_free(&cpu);
    w.points[hidden * (size_t)dim] += 1e-9;
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);
    w.weights[hidden] -= 1.0;
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);
    w.weights[hidden] += 3.0;                           /* above all others */
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    w.weights[hidden] += 100.0;
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    for (i = 0; i < count; i++) {
        w.weights[i] = 7.0;
    }
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    free(w.weights);
    w.weights = NULL;
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);        /* equal weights are none */
    walk_end(&w);
}

/* Steps of all kinds in turn: few points, on a line, left to the CPU, another dimension, without neighbors. */
static void test_walk_any(void)
{
    const size_t count = 20000;
    size_t i;
    walk w;
    pbw_cuda_patient = 0;
    walk_start(&w, 3, INPUT_SPHERE, -1, count);
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);      /* by the CPU */
    walk_scale(&w, 2.0);
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);
    walk_turn(&w);
    CHECK_EQUAL(walk_step(&w, 0, whichever), PBW_OK);
    pbw_cuda_patient = 1;
    w.dim = 2;
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    w.count = 5;
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);      /* few points are left to the CPU */
    w.count = 0;
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_DEGENERATE);
    w.count = 2000;
    for (i = 0; i < 4000; i++) {
        w.points[i] = (double)(i / 2);
    }
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_DEGENERATE);
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_DEGENERATE);
    input_fill(INPUT_UNIFORM, 2, w.count, 1, w.points);
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    w.points[7] = HUGE_VAL;
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_ERROR_NOT_FINITE);
    w.points[7] = 0.5;
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);
    pbw_cuda_loop_free(w.loop);
    w.loop = NULL;
    w.options.flags = PBW_NO_NEIGHBORS;
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    CHECK_EQUAL(walk_step(&w, 0, broken), PBW_OK);
    walk_end(&w);
}

/* Every allocation of device memory fails once, in a step that builds and in steps that keep the mesh; the next step
   is as if nothing had been. */
static void test_walk_failing(int dim)
{
    pbw_status status = PBW_ERROR_BACKEND;
    long k;
    int step;
    walk w;
    walk_start(&w, dim, INPUT_UNIFORM, INPUT_WEIGHTS_HIDING, 2000);
    w.cpu = NULL;
    for (step = 0; step < 3; step++) {
        for (k = 1; k == 1 || status != PBW_OK; k += (long)fewer) {
            CHECK_EQUAL(walk_step(&w, 1, broken), PBW_OK);
            if (step == 2) {
                walk_turn(&w);
            }
            pbw_cuda_fail_at = k;
            status = walk_step(&w, step == 0, step == 0 ? broken : kept);
            CHECK_EQUAL(status, pbw_cuda_fail_at > 0 ? PBW_OK : PBW_ERROR_BACKEND);
            if (pbw_cuda_fail_at == 0 && !CHECK(w.message[0] != '\0' && k < 1000)) {
                break;
            }
            pbw_cuda_fail_at = 0;
        }
        CHECK(k > 10);
    }
    walk_end(&w);
}

/* What a loop has stays as it is: no step takes more than one before it.  initcheck takes device memory of its own. */
static void test_walk_memory(void)
{
    size_t at_first = 0, available, all;
    int step;
    walk w;
    walk_start(&w, 3, INPUT_UNIFORM, -1, 100000);
    for (step = 0; step < 24; step++) {
        walk_jitter(&w, step % 3 == 0 ? 0.0 : 1e-3);
        CHECK_EQUAL(walk_step(&w, step % 4 == 0, whichever), PBW_OK);
        CHECK(cudaDeviceSynchronize() == cudaSuccess && cudaMemGetInfo(&available, &all) == cudaSuccess);
        at_first = step == 3 ? available : at_first;
    }
    if (!leaves_memory && !CHECK(available + ((size_t)32 << 20) >= at_first)) {
        test_say("%zu bytes more", at_first - available);
    }
    walk_end(&w);
}

static void test_walk_calls(void)
{
    char one[24] = { 0 };
    void *there = to_device(one, sizeof one);
    pbw_cuda_points in;
    pbw_cuda_mesh mesh;
    pbw_cuda_loop *loop = NULL;
    pbw_options options;
    pbw_status status = PBW_CANCELLED;
    size_t left = 8;
    walk w;
    memset(&options, 0, sizeof options);
    memset(&in, 0, sizeof in);
    pbw_cuda_loop_free(NULL);
    CHECK_EQUAL(pbw_cuda_loop_create(NULL, NULL, NULL, NULL), PBW_ERROR_ARGUMENT);
    options.threads = -1;
    CHECK_EQUAL(pbw_cuda_loop_create(&options, NULL, NULL, &loop), PBW_ERROR_ARGUMENT);
    options.threads = 0;
    options.resize = no_more;
    options.resize_user = &left;
    CHECK_EQUAL(pbw_cuda_loop_create(&options, NULL, NULL, &loop), PBW_ERROR_MEMORY);
    CHECK(loop == NULL);
    CHECK_EQUAL(pbw_cuda_loop_create(NULL, NULL, NULL, &loop), PBW_OK);
    CHECK_EQUAL(pbw_cuda_loop_step(NULL, &in, &mesh), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_cuda_loop_step(loop, NULL, &mesh), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_cuda_loop_step(loop, &in, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_cuda_loop_step(loop, &in, &mesh), PBW_ERROR_ARGUMENT);
    in.dim = 3;
    in.count = 1;
    CHECK_EQUAL(pbw_cuda_loop_step(loop, &in, &mesh), PBW_ERROR_ARGUMENT);
    in.points = there;
    CHECK_EQUAL(pbw_cuda_loop_step(loop, &in, &mesh), PBW_ERROR_BACKEND);
    pbw_cuda_loop_free(loop);
    cudaFree(there);
    walk_start(&w, 3, INPUT_UNIFORM, -1, 20000);
    w.options.progress = stop_later;
    for (stop_at = 1; status == PBW_CANCELLED; stop_at = 2 * (long)fewer * stop_at + 1) {
        calls = 0;
        status = walk_step(&w, 0, whichever);
        CHECK_EQUAL(status, calls >= stop_at ? PBW_CANCELLED : PBW_OK);
    }
    stop_at = 1000000000;
    CHECK_EQUAL(walk_step(&w, 0, kept), PBW_OK);
    pbw_cuda_loop_free(w.loop);
    w.loop = NULL;
    w.options.memory_limit = 20000 * 100;
    w.options.progress = NULL;
    CHECK_EQUAL(walk_step(&w, 0, whichever), PBW_ERROR_BACKEND);
    w.options.memory_limit = 0;                         /* the loop has a copy */
    CHECK_EQUAL(walk_step(&w, 0, whichever), PBW_ERROR_BACKEND);
    walk_end(&w);
}

static void test_walks(void)
{
    int dim, kind, weights;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            for (weights = -1; weights <= INPUT_WEIGHTS_HIDING; weights += INPUT_WEIGHTS_HIDING + 1) {
                if (test_begin("loop: %dD %s%s", dim, input_name(kind), weights < 0 ? "" : ", weights")) {
                    test_walk(dim, kind, weights, kind == INPUT_MOMENT ? 200 : 1500);
                    test_end();
                }
            }
        }
        if (test_begin("loop: %dD hidden points", dim)) {
            test_walk_hidden(dim);
            test_end();
        }
        if (test_begin("loop: %dD failing allocations", dim)) {
            test_walk_failing(dim);
            test_end();
        }
    }
    if (test_begin("loop: steps of any kind")) {
        test_walk_any();
        test_end();
    }
    if (test_begin("loop: memory")) {
        test_walk_memory();
        test_end();
    }
    if (test_begin("loop: calls")) {
        test_walk_calls();
        test_end();
    }
}

static void test_failures(void)
{
    const size_t count = 50000;
    double *points = (double *)malloc(count * 3 * sizeof *points);
    char message[256] = "";
    pbw_options options;
    pbw_mesh mesh;
    int cards;
    input_fill(INPUT_UNIFORM, 3, count, 1, points);
    memset(&options, 0, sizeof options);
    options.message = message;
    options.message_size = sizeof message;
    if (test_begin("no such device")) {
        const int device[2] = { 0, 63 }, wrong[2] = { 0, -1 };
        CHECK(pbw_cuda_backend(-1) == NULL && pbw_cuda_backend_multi(wrong, 2) == NULL
              && pbw_cuda_backend_multi(device, 0) == NULL && pbw_cuda_backend_multi(device, 17) == NULL
              && pbw_cuda_backend_multi(device, 2) == pbw_cuda_backend_multi(device, 2));
        options.backend = pbw_cuda_backend_multi(device, 2);
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_ERROR_BACKEND);
        CHECK(strncmp(message, "device 63", 9) == 0 && meshes_is_empty(&mesh));
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
    for (cards = 1; cards <= 3; cards++) {
        options.backend = team_of(cards);
        if (test_begin("cancelled, %d cards", cards)) {
            options.progress = stop_at_once;
            CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_CANCELLED);
            CHECK(meshes_is_empty(&mesh));
            options.progress = NULL;
            cancel_later(points, count, options);
            test_end();
        }
        if (test_begin("out of memory on the host, %d cards", cards)) {
            size_t left;
            for (left = 1000; left < 30000000; left = left * fewer * 3 / 2) {
                size_t available = left;
                pbw_status status;
                options.resize = no_more;
                options.resize_user = &available;
                status = pbw_triangulate(3, points, NULL, count, &options, &mesh);
                CHECK(status == PBW_OK || (status == PBW_ERROR_MEMORY && meshes_is_empty(&mesh)));
                pbw_free(&mesh);
            }
            options.resize = NULL;
            test_end();
        }
        if (test_begin("memory limit, %d cards", cards)) {
            size_t needed = 0, said = 0, limit;
            options.memory_limit = limit = count * 200;
            CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_ERROR_BACKEND);
            if (!CHECK(sscanf(message, "too little device memory: %zu bytes are needed, %zu are available", &needed,
                              &said) == 2 && needed > limit && said == limit && meshes_is_empty(&mesh))) {
                test_say("%s", message);
            }
            options.flags = PBW_BACKEND_OR_CPU;
            CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_ERROR_MEMORY);
            options.memory_limit = limit = count * 320;
            CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_OK);
            CHECK((cards > 1 || !mesh.statistics.by_backend) && mesh.statistics.peak_bytes <= limit);
            pbw_free(&mesh);
            options.flags = 0;
            limit = count * (cards == 1 ? 680 : cards == 2 ? 400 : 320);      /* a share needs less */
            options.memory_limit = limit;
            if (!CHECK_EQUAL(pbw_triangulate(3, points, NULL, count, &options, &mesh), PBW_OK)) {
                test_say("%s", message);
            }
            CHECK(mesh.statistics.by_backend && mesh.statistics.peak_bytes <= limit);
            pbw_free(&mesh);
            options.memory_limit = 0;
            test_end();
        }
    }
    options.backend = pbw_cuda_backend(0);
    pbw_cuda_patient = 0;
    for (cards = 0; cards < 2; cards++) {               /* left to the CPU; the rung that points on surfaces have */
        const int kind = cards == 0 ? INPUT_SPHERE : INPUT_TERRAIN;
        double *others = (double *)zoo_grow(NULL, count * 3 * sizeof *others);
        input_fill(kind, 3, count, 1, others);
        if (test_begin("cancelled: %s", input_name(kind))) {
            cancel_later(others, count, options);
            test_end();
        }
        if (test_begin("memory limit: %s", input_name(kind))) {
            pbw_status status = PBW_ERROR_BACKEND;
            for (options.memory_limit = count * 100; status != PBW_OK && options.memory_limit < count * 2000;
                 options.memory_limit += count * 30 * fewer) {
                message[0] = '\0';
                status = pbw_triangulate(3, others, NULL, count, &options, &mesh);
                if (!CHECK(status == PBW_OK || status == PBW_ERROR_MEMORY
                           || (status == PBW_ERROR_BACKEND && strncmp(message, "too little device memory", 24) == 0))
                    || !CHECK(status == PBW_OK ? mesh.statistics.by_backend == (kind != INPUT_SPHERE)
                                           : meshes_is_empty(&mesh))) {
                    test_say("%s", message);
                }
                pbw_free(&mesh);
            }
            CHECK_EQUAL(status, PBW_OK);
            options.memory_limit = 0;
            test_end();
        }
        free(others);
    }
    pbw_cuda_patient = 1;
    if (test_begin("too little device memory")) {
        const size_t many = 2000000;                        /* 48 MB, to build more than 300 bytes each, 600 MB */
        size_t left, available, all, needed, said;
        double *more = (double *)zoo_grow(NULL, many * 3 * sizeof *more);
        void *block = NULL;
        input_fill(INPUT_UNIFORM, 3, many, 1, more);
        for (left = 32u << 20; left <= 256u << 20; left *= 8) {
            options.flags = 0;
            CHECK(cudaDeviceSynchronize() == cudaSuccess && cudaMemGetInfo(&available, &all) == cudaSuccess
                  && available > left && cudaMalloc(&block, available - left) == cudaSuccess);
            CHECK_EQUAL(pbw_triangulate(3, more, NULL, many, &options, &mesh), PBW_ERROR_BACKEND);
            CHECK(meshes_is_empty(&mesh));
            if (!CHECK(sscanf(message, "too little device memory: %zu bytes are needed, %zu are available", &needed,
                              &said) == 2
                       && needed > many * 300 && needed < many * 1000 && said <= left + (128u << 20))) {
                test_say("%s", message);
            }
            options.flags = PBW_BACKEND_OR_CPU;
            CHECK_EQUAL(pbw_triangulate(3, more, NULL, many, &options, &mesh), PBW_OK);
            CHECK(!mesh.statistics.by_backend);
            pbw_free(&mesh);
            cudaFree(block);
        }
        options.flags = 0;
        CHECK_EQUAL(pbw_triangulate(3, more, NULL, many, &options, &mesh), PBW_OK);
        CHECK(mesh.statistics.by_backend);
        pbw_free(&mesh);
        free(more);
        test_end();
    }
    if (test_begin("not finite")) {
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
    leaves_memory = getenv("CUDA_TEST_LEAVE") != NULL;
    fewer = getenv("CUDA_TEST_FEWER") != NULL ? 20 : 1;
    memset(&options, 0, sizeof options);
    options.backend = pbw_cuda_backend(0);
    options.message = message;
    options.message_size = sizeof message;
    if (pbw_triangulate(3, cube, NULL, 8, &options, &mesh) == PBW_ERROR_BACKEND) {
        printf("skipped: %s\n0 passed, 0 failed, 1 skipped\n", message);
        return 0;
    }
    pbw_free(&mesh);
    pbw_cuda_patient = 1;                       /* every input reaches every rung */
    pbw_cuda_piece = 4096;                      /* few points have many pieces */
    test_no_pinned();
    test_zoo();
    test_random();
    test_kinds(20000 / fewer);
    test_verdicts(3000);
    test_forms();
    test_failures();
    test_failures_on_device();
    test_walks();
    test_teams();
    test_declined();
    test_spheres();
    test_surfaces();
    if (test_begin("cancelled soon")) {
        test_soon();
        test_end();
    }
    printf("%ld builds by the GPU, %ld left to the CPU\n", by_gpu, by_cpu);
    return test_finish();
}
