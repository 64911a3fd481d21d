/* cuda_cells.c: cells by pbw_cuda.cu against pbw_cells.h, byte for byte: the zoo, all kinds of points and weights,
   few points, floats, a loop, periodic boxes; in boxes around, within and beside the points, and in the whole space;
   with facets and alone.  The volumes in a box add up to it. */
#define PBW_IMPLEMENTATION
#define PBW_CUDA
#include "../pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "../examples/lib/pbw_cells.h"
#include "test.h"
#include "meshes.h"
#include <cuda_runtime_api.h>
#include <math.h>

extern int pbw_cuda_patient;                    /* of a pbw_cuda.cu compiled for tests */
extern long pbw_cuda_fail_at;
extern size_t pbw_cuda_piece;

static void *to_device(const void *from, size_t bytes)
{
    void *block = NULL;
    CHECK(cudaMalloc(&block, bytes > 0 ? bytes : 1) == cudaSuccess
          && cudaMemcpy(block, from, bytes, cudaMemcpyHostToDevice) == cudaSuccess
          && cudaDeviceSynchronize() == cudaSuccess);
    return block;
}

/* 1 if an array on the device is the same as one of the host; one without items may be NULL. */
static int same(const void *there, const void *here, size_t bytes)
{
    char *copy = (char *)zoo_grow(NULL, bytes + 1);
    const int is_none = bytes == 0 || (there == NULL && here == NULL);
    const int equal = is_none || (there != NULL && here != NULL
                                  && cudaMemcpy(copy, there, bytes, cudaMemcpyDefault) == cudaSuccess
                                  && memcmp(copy, here, bytes) == 0);
    free(copy);
    return equal;
}

/* Whether all numbers are 0 or of a size that pbw_cells_of takes.  Beyond, areas may be no numbers, and the bits
   of these vary.  Products may underflow; their errors then differ between processors with and without fused
   operations. */
static int is_in_range(const double *numbers, size_t count)
{
    size_t i;
    for (i = 0; i < count && (numbers[i] == 0 || (fabs(numbers[i]) >= 1e-57 && fabs(numbers[i]) <= 1e60)); i++) {
    }
    return i == count;
}

/* The same of areas; in_range: byte for byte, else to 1e-9. */
static int same_areas(const double *there, const double *here, size_t count, int in_range)
{
    double *copy = (double *)zoo_grow(NULL, (count + 1) * sizeof *copy);
    int equal = (count == 0 || (there == NULL) == (here == NULL))
             && (there == NULL || cudaMemcpy(copy, there, count * sizeof *copy, cudaMemcpyDefault) == cudaSuccess);
    size_t i;
    for (i = 0; i < count && there != NULL && equal; i++) {
        equal = memcmp(copy + i, here + i, sizeof *copy) == 0
             || (!in_range && ((isnan(copy[i]) && isnan(here[i]))
                               || fabs(copy[i] - here[i]) <= 1e-9 * fabs(here[i])));
        if (!equal) {
            test_say("area %lu: %.17g, not %.17g", (unsigned long)i, copy[i], here[i]);
        }
    }
    free(copy);
    return equal;
}

static int same_cells(const pbw_cells *cpu, const pbw_cuda_cells *gpu, int in_range)
{
    const size_t count = cpu->cell_count;
    return CHECK_EQUAL(gpu->dim, cpu->dim) && CHECK_EQUAL(gpu->cell_count, count)
           && CHECK_EQUAL(gpu->facet_count, cpu->facet_count)
           && CHECK(same(gpu->volumes, cpu->volumes, count * sizeof(double)))
           && CHECK(same(gpu->centroids, cpu->centroids, count * (size_t)cpu->dim * sizeof(double)))
           && CHECK(same(gpu->first, cpu->first, (count + 1) * sizeof(size_t)))
           && CHECK(same(gpu->neighbors, cpu->neighbors, cpu->facet_count * sizeof(pbw_index)))
           && CHECK(same_areas(gpu->areas, cpu->areas, cpu->facet_count, in_range));
}

/* The same from points of the host to arrays of the host. */
static void compare_host(const pbw_mesh *mesh, const double *box)
{
    pbw_domain domain;
    pbw_cells cpu;
    pbw_cuda_cells gpu, none;
    pbw_status expected;
    memset(&domain, 0, sizeof domain);
    memset(&none, 0, sizeof none);
    domain.box = box;
    expected = pbw_cells_of(mesh, &domain, PBW_CELLS_FACETS, NULL, &cpu);
    CHECK_EQUAL(pbw_cuda_cells_of_host(mesh->dim, mesh->points, mesh->weights, mesh->point_count, box, 0,
                                       PBW_CUDA_FACETS, NULL, pbw_triangulate, &gpu), expected);
    if (expected == PBW_OK || expected == PBW_DEGENERATE) {
        same_cells(&cpu, &gpu, is_in_range(mesh->points, mesh->point_count * (size_t)mesh->dim));
    }
    pbw_cells_free(&cpu);
    pbw_cuda_cells_free(&gpu, NULL);
    CHECK(memcmp(&gpu, &none, sizeof gpu) == 0);
}

/* Cells of one mesh in one box. */
static void compare_in(const pbw_mesh *mesh, const pbw_cuda_mesh *there, const pbw_cuda_points *points,
                       const double *box, unsigned facets)
{
    pbw_domain domain;
    pbw_cells cpu;
    pbw_cuda_cells gpu, none;
    pbw_options options;
    pbw_status expected, status;
    char message[256] = "";
    double volume = 1, sum = 0;
    size_t i;
    memset(&domain, 0, sizeof domain);
    memset(&options, 0, sizeof options);
    memset(&none, 0, sizeof none);
    memset(&gpu, 1, sizeof gpu);
    domain.box = box;
    options.message = message;
    options.message_size = sizeof message;
    expected = pbw_cells_of(mesh, &domain, facets != 0 ? PBW_CELLS_FACETS : 0, NULL, &cpu);
    status = pbw_cuda_cells_of(there, points, box, facets, &options, NULL, pbw_triangulate, &gpu);
    if (!CHECK_EQUAL(status, expected)) {
        test_say("%s", message);
    }
    if (status == PBW_OK || status == PBW_DEGENERATE) {
        if (!same_cells(&cpu, &gpu, is_in_range(mesh->points, mesh->point_count * (size_t)mesh->dim))) {
            test_say("%s%s", box == NULL ? "in space" : "in a box", facets != 0 ? ", with facets" : "");
        }
        for (i = 0; i < 3 && box != NULL; i++) {
            volume *= i < (size_t)mesh->dim ? box[i + (size_t)mesh->dim] - box[i] : 1;
        }
        for (i = 0; i < cpu.cell_count && box != NULL; i++) {
            sum += cpu.volumes[i];
        }
        if (box != NULL && cpu.cell_count > 0 && volume > 1e-100 && volume < 1e100) {    /* else out of range */
            CHECK(fabs(sum - volume) <= 1e-9 * volume);
        }
    }
    pbw_cells_free(&cpu);
    pbw_cuda_cells_free(&gpu, NULL);
    CHECK(memcmp(&gpu, &none, sizeof gpu) == 0);
}

static void box_of(int dim, const double *points, size_t count, double *low, double *high)
{
    size_t i;
    int k;
    for (k = 0; k < dim; k++) {
        low[k] = high[k] = count > 0 ? points[k] : 0;
        for (i = (size_t)k; i < count * (size_t)dim; i += (size_t)dim) {
            low[k] = points[i] < low[k] ? points[i] : low[k];
            high[k] = points[i] > high[k] ? points[i] : high[k];
        }
        high[k] = high[k] > low[k] ? high[k] : low[k] + 1;
    }
}

/* All cells of one input. */
static void compare(int dim, const double *points, const double *weights, size_t count, int is_float)
{
    static const double part[3][2] = { { -0.01, 1.02 }, { 0.3, 0.61 }, { 0.9, 1.4 } };
    double low[3], high[3], box[6];
    pbw_cuda_points there;
    pbw_cuda_mesh mesh;
    pbw_mesh cpu;
    pbw_status expected = pbw_triangulate(dim, points, weights, count, NULL, &cpu), status;
    int i, k;
    memset(&there, 0, sizeof there);
    memset(&mesh, 0, sizeof mesh);
    there.dim = dim;
    there.count = count;
    there.is_float = is_float;
    there.points = to_device(points, count * (size_t)dim * sizeof(double));
    there.weights = weights == NULL ? NULL : to_device(weights, count * sizeof(double));
    if (is_float) {                             /* the numbers are floats */
        float *narrow = (float *)zoo_grow(NULL, (count * (size_t)dim + 1) * sizeof *narrow);
        size_t j;
        for (j = 0; j < count * (size_t)dim; j++) {
            narrow[j] = (float)points[j];
        }
        cudaFree((void *)(uintptr_t)there.points);
        there.points = to_device(narrow, count * (size_t)dim * sizeof *narrow);
        free(narrow);
    }
    status = pbw_cuda_triangulate(dim, is_float, there.points, there.weights, count, NULL, NULL, pbw_triangulate,
                                  &mesh);
    CHECK_EQUAL(status, expected);
    box_of(dim, points, count, low, high);
    for (i = 0; i < 8 && (status == PBW_OK || status == PBW_DEGENERATE); i++) {
        for (k = 0; k < dim && i / 2 < 3; k++) {
            box[k] = low[k] + part[i / 2][0] * (high[k] - low[k]);
            box[dim + k] = low[k] + part[i / 2][1] * (high[k] - low[k]);
        }
        compare_in(&cpu, &mesh, &there, i / 2 < 3 ? box : NULL, i % 2 != 0 ? PBW_CUDA_FACETS : 0);
        if (i == 1) {
            compare_host(&cpu, box);
        }
    }
    pbw_cuda_free(&mesh, NULL);
    pbw_free(&cpu);
    cudaFree((void *)(uintptr_t)there.points);
    cudaFree((void *)(uintptr_t)there.weights);
}

static void test_zoo(void)
{
    zoo animals;
    size_t i;
    zoo_fill(&animals);
    for (i = 0; i < animals.count; i++) {
        const zoo_input *in = animals.items + i;
        if (test_begin("cells: zoo: %s", in->name)) {
            compare(in->dim, in->points, in->weights, in->count, 0);
            test_end();
        }
    }
    zoo_free(&animals);
}

static void test_kinds(size_t count)
{
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points);
    double *weights = (double *)zoo_grow(NULL, count * sizeof *weights);
    int dim, kind, weight_kind;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            const size_t n = kind == INPUT_MOMENT ? 200 : kind == INPUT_SPHERE ? count / 10 : count;
            if (test_begin("cells: %dD %s, %lu", dim, input_name(kind), (unsigned long)n)) {
                input_fill(kind, dim, n, (uint64_t)test_seed, points);
                compare(dim, points, NULL, n, 0);
                test_end();
            }
        }
        for (weight_kind = 0; weight_kind < INPUT_WEIGHTS_KINDS; weight_kind++) {
            for (kind = 0; kind < 2; kind++) {
                const int points_kind = kind == 0 ? INPUT_UNIFORM : INPUT_LATTICE;
                if (test_begin("cells: %dD %s, weights %s, %lu", dim, input_name(points_kind),
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

/* 0 to 9 points: none, on a line, in a plane; with weights; floats. */
static void test_few(void)
{
    static const double grid[9 * 3] = { 0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1,
                                        0.25, 0.5, 0.75 };
    static const double weights[9] = { 0, 0.25, 0.5, 0, 0, 0.125, 0, -1, 0.0625 };
    size_t count;
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        for (count = 0; count <= 9; count++) {
            if (test_begin("cells: %dD, %lu points", dim, (unsigned long)count)) {
                double points[9 * 3];
                size_t i;
                for (i = 0; i < count * (size_t)dim; i++) {
                    points[i] = grid[i / (size_t)dim * 3 + i % (size_t)dim];
                }
                compare(dim, points, NULL, count, 0);
                compare(dim, points, weights, count, 0);
                compare(dim, points, NULL, count, 1);
                test_end();
            }
        }
    }
}

/* An allocator that fails at the n-th call, and counts what is not freed. */
static long host_fail_at, host_blocks;

static void *host_resize(void *user, void *block, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        host_blocks -= block != NULL;
        free(block);
        return NULL;
    }
    if (--host_fail_at == 0) {
        return NULL;
    }
    host_blocks += block == NULL;
    return realloc(block, new_size);
}

static void test_host_failures(int dim, const double *points)
{
    char message[100] = "";
    pbw_options options;
    pbw_cuda_cells cells;
    pbw_status status = PBW_ERROR_MEMORY;
    long i;
    memset(&options, 0, sizeof options);
    options.resize = host_resize;
    options.message = message;
    options.message_size = sizeof message;
    for (i = 1; i < 40 && status != PBW_OK; i++) {
        host_fail_at = i;
        status = pbw_cuda_cells_of_host(dim, points, NULL, 300, NULL, 0, 0, &options, pbw_triangulate, &cells);
        CHECK(status == PBW_OK || (status == PBW_ERROR_MEMORY && cells.volumes == NULL));
        CHECK_EQUAL(host_blocks, status == PBW_OK ? 1 : 0);
    }
    CHECK(status == PBW_OK && i > 2);
    pbw_cuda_cells_free(&cells, NULL);
    CHECK_EQUAL(host_blocks, 0);
    host_fail_at = 0;
    options.flags = PBW_NO_NEIGHBORS;
    CHECK_EQUAL(pbw_cuda_cells_of_host(dim, points, NULL, 300, NULL, 0, 0, &options, NULL, &cells),
                PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_cuda_cells_of_host(4, points, NULL, 300, NULL, 0, 0, NULL, NULL, &cells), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_cuda_cells_of_host(dim, NULL, NULL, 300, NULL, 0, 0, NULL, NULL, &cells), PBW_ERROR_ARGUMENT);
    options.flags = 0;
    options.memory_limit = 5000;
    CHECK_EQUAL(pbw_cuda_cells_of_host(dim, points, NULL, 300, NULL, 0, 0, &options, NULL, &cells),
                PBW_ERROR_BACKEND);
    CHECK(message[0] != 0);
    CHECK_EQUAL(host_blocks, 0);
}

/* Arguments that are refused, and each allocation that may fail. */
static void test_failures(void)
{
    double points[3 * 300], box[6] = { 0, 0, 0, 1, 1, 1 }, flat[6] = { 0, 0, 0, 1, 0, 1 };
    pbw_cuda_points there;
    pbw_cuda_mesh mesh;
    pbw_cuda_cells cells;
    pbw_options options;
    long i;
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (!test_begin("cells: %dD failures", dim)) {
            continue;
        }
        memset(&there, 0, sizeof there);
        memset(&options, 0, sizeof options);
        input_fill(INPUT_UNIFORM, dim, 300, (uint64_t)test_seed, points);
        there.dim = dim;
        there.count = 300;
        there.points = to_device(points, sizeof points);
        CHECK_EQUAL(pbw_cuda_triangulate(dim, 0, there.points, NULL, 300, NULL, NULL, pbw_triangulate, &mesh),
                    PBW_OK);
        CHECK_EQUAL(pbw_cuda_cells_of(&mesh, &there, flat, 0, NULL, NULL, NULL, &cells),
                    PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_cuda_cells_of(&mesh, &there, NULL, 8, NULL, NULL, NULL, &cells), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_cuda_cells_of(&mesh, NULL, NULL, 0, NULL, NULL, NULL, &cells), PBW_ERROR_ARGUMENT);
        there.count = 299;
        CHECK_EQUAL(pbw_cuda_cells_of(&mesh, &there, NULL, 0, NULL, NULL, NULL, &cells), PBW_ERROR_ARGUMENT);
        there.count = 300;
        options.memory_limit = 5000;
        CHECK_EQUAL(pbw_cuda_cells_of(&mesh, &there, NULL, 0, &options, NULL, NULL, &cells), PBW_ERROR_BACKEND);
        for (i = 1; i < 40; i++) {
            pbw_status status;
            pbw_cuda_fail_at = i;
            status = pbw_cuda_cells_of(&mesh, &there, dim == 3 ? box : box + 1, PBW_CUDA_FACETS, NULL, NULL, NULL,
                                       &cells);
            if (status == PBW_OK) {
                break;
            }
            CHECK_EQUAL(status, PBW_ERROR_BACKEND);
            CHECK(cells.volumes == NULL && cells.areas == NULL);
        }
        pbw_cuda_fail_at = 0;
        CHECK(i > 5 && i < 40);
        pbw_cuda_cells_free(&cells, NULL);
        test_host_failures(dim, points);
        pbw_cuda_free(&mesh, NULL);
        cudaFree((void *)(uintptr_t)there.points);
        test_end();
    }
}

/* A loop whose points move to their centroids: the same cells as of each mesh alone. */
static void test_loop(size_t count)
{
    static const double box[6] = { 0, 0, 0, 1, 1, 1 };
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points);
    pbw_cuda_loop *loop = NULL;
    pbw_cuda_points there;
    void *start;
    int dim, step;
    for (dim = 2; dim <= 3; dim++) {
        if (!test_begin("cells: %dD loop", dim)) {
            continue;
        }
        memset(&there, 0, sizeof there);
        input_fill(INPUT_UNIFORM, dim, count, (uint64_t)test_seed, points);
        start = to_device(points, count * (size_t)dim * sizeof(double));
        there.dim = dim;
        there.count = count;
        there.points = start;
        CHECK_EQUAL(pbw_cuda_loop_create(NULL, NULL, pbw_triangulate, &loop), PBW_OK);
        for (step = 0; step < 4; step++) {
            pbw_cuda_mesh mesh;
            pbw_cuda_cells cells;
            pbw_mesh cpu;
            pbw_cells expected;
            pbw_domain domain;
            memset(&domain, 0, sizeof domain);
            domain.box = dim == 3 ? box : box + 1;
            CHECK(cudaMemcpy(points, there.points, count * (size_t)dim * sizeof(double), cudaMemcpyDeviceToHost)
                  == cudaSuccess);
            CHECK_EQUAL(pbw_cuda_loop_step(loop, &there, &mesh), PBW_OK);
            CHECK_EQUAL(pbw_cuda_loop_cells(loop, &there, domain.box, step % 2 != 0 ? PBW_CUDA_FACETS : 0, &cells),
                        PBW_OK);
            CHECK_EQUAL(pbw_triangulate(dim, points, NULL, count, NULL, &cpu), PBW_OK);
            CHECK_EQUAL(pbw_cells_of(&cpu, &domain, step % 2 != 0 ? PBW_CELLS_FACETS : 0, NULL, &expected), PBW_OK);
            same_cells(&expected, &cells, 1);
            pbw_cells_free(&expected);
            pbw_free(&cpu);
            there.points = cells.centroids;
        }
        pbw_cuda_loop_free(loop);
        cudaFree(start);
        test_end();
    }
    free(points);
}

/* Volumes up to rounding. */
static void near_cells(const pbw_cells *cpu, const pbw_cuda_cells *gpu, double whole)
{
    const size_t count = cpu->cell_count;
    double *volumes = (double *)zoo_grow(NULL, (count + 1) * sizeof *volumes), most = 0;
    size_t i;
    CHECK(gpu->cell_count == count && cudaMemcpy(volumes, gpu->volumes, count * sizeof *volumes, cudaMemcpyDefault)
                                      == cudaSuccess);
    for (i = 0; i < count; i++) {
        most = fmax(most, fabs(volumes[i] - cpu->volumes[i]));
    }
    if (!CHECK(most < 1e-8 * whole / (double)count)) {
        test_say("a volume is off by %g of %g", most, whole / (double)count);
    }
    free(volumes);
}

/* Points in a periodic box: the bytes of the CPU, or with is_near its cells up to rounding; or a status that says why
   there are none. */
static void compare_periodic(int dim, const double *points, const double *weights, size_t count, const double *box,
                             unsigned axes, pbw_status expected, int is_near)
{
    pbw_domain domain;
    pbw_cells cpu;
    pbw_cuda_cells gpu;
    pbw_cuda_points there;
    pbw_options options;
    char message[200] = "";
    unsigned facets;
    memset(&domain, 0, sizeof domain);
    memset(&there, 0, sizeof there);
    memset(&options, 0, sizeof options);
    options.message = message;
    options.message_size = sizeof message;
    domain.box = box;
    domain.periodic = axes;
    there.dim = dim;
    there.count = count;
    there.points = to_device(points, count * (size_t)dim * sizeof(double));
    there.weights = weights == NULL ? NULL : to_device(weights, count * sizeof(double));
    for (facets = 0; facets < 2; facets++) {
        const pbw_status status = pbw_cuda_cells_periodic(&there, box, axes, facets, &options, NULL,
                                                          pbw_triangulate, &gpu);
        if (CHECK_EQUAL(status, expected) && status == PBW_OK) {
            CHECK_EQUAL(pbw_cells_periodic(dim, points, weights, count, &domain, facets, NULL, &cpu), PBW_OK);
            if (is_near) {
                near_cells(&cpu, &gpu, (box[dim] - box[0]) * (box[dim + 1] - box[1])
                                       * (dim == 3 ? box[5] - box[2] : 1));
            } else {
                same_cells(&cpu, &gpu, 1);
                CHECK(same(gpu.shifts, cpu.shifts, cpu.facet_count * (size_t)dim));
            }
            CHECK(same(gpu.sites, cpu.sites, count * (size_t)dim * sizeof(double)));
            pbw_cells_free(&cpu);
        } else if (status != expected) {
            test_say("%s", message);
        }
        CHECK(status != PBW_ERROR_BACKEND || strstr(message, "pbw_cells_periodic") != NULL);
        pbw_cuda_cells_free(&gpu, NULL);
    }
    cudaFree((void *)(uintptr_t)there.points);
    cudaFree((void *)(uintptr_t)there.weights);
}

static void test_periodic(size_t count)
{
    static const double boxes[2][6] = { { 0, 0, 0, 1, 1, 1 }, { -0.3, 0.7, 5, 0.7, 1.6, 6.3 } };
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points);
    double *weights = (double *)zoo_grow(NULL, count * sizeof *weights);
    int dim, b;
    size_t i, k;
    for (dim = 2; dim <= 3; dim++) {
        const unsigned all = (1u << dim) - 1;
        for (b = 0; b < 2; b++) {
            if (test_begin("cells: %dD periodic box %d", dim, b)) {
                double box[6];
                memcpy(box, boxes[b], sizeof box);
                memcpy(box + dim, boxes[b] + 3, (size_t)dim * sizeof *box);
                input_fill(INPUT_UNIFORM, dim, count, (uint64_t)test_seed, points);
                for (i = 0; i < count; i++) {
                    weights[i] = 1e-5 * (double)(i % 7);
                    for (k = 0; k < (size_t)dim; k++) {           /* over three periods */
                        points[i * (size_t)dim + k] *= 3 * (box[(size_t)dim + k] - box[k]);
                    }
                }
                compare_periodic(dim, points, NULL, count, box, all, PBW_OK, dim == 2);
                compare_periodic(dim, points, weights, count, box, all, PBW_OK, dim == 2);
                memcpy(points + 5 * dim, points, (size_t)dim * sizeof *points);  /* a duplicate */
                compare_periodic(dim, points, NULL, count, box, all, PBW_OK, dim == 2);
                compare_periodic(dim, box, NULL, 1, box, all, PBW_ERROR_BACKEND, 0);          /* one in a corner */
                compare_periodic(dim, points, NULL, 0, box, all, PBW_ERROR_ARGUMENT, 0);
                for (i = 0; i < count * (size_t)dim; i += (size_t)dim) {        /* a gap */
                    points[i] = box[0] + 0.9 * (points[i] - box[0] - floor(points[i] - box[0]));
                }
                compare_periodic(dim, points, NULL, count, box, all, PBW_OK, 1);
                points[7] = HUGE_VAL;
                compare_periodic(dim, points, NULL, count, box, all, PBW_ERROR_NOT_FINITE, 0);
                test_end();
            }
        }
    }
    free(points);
    free(weights);
}

/* Boxes that repeat along some axes and have walls along the others; points reach 2 % beyond the walls.  From the
   host the same cells come. */
static void test_walls(size_t count)
{
    static const double box[6] = { -0.3, 0.7, 5, 0.7, 1.6, 6.3 };
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points);
    double *weights = (double *)zoo_grow(NULL, count * sizeof *weights);
    unsigned axes;
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        for (axes = 1; axes + 1 < 1u << dim; axes++) {
            if (test_begin("cells: %dD periodic along axes %u", dim, axes)) {
                double own[6];
                pbw_cuda_cells made;
                pbw_domain domain;
                pbw_cells cpu;
                size_t i, k;
                memcpy(own, box, sizeof own);
                memcpy(own + dim, box + 3, (size_t)dim * sizeof *own);
                input_fill(INPUT_UNIFORM, dim, count, (uint64_t)test_seed, points);
                for (i = 0; i < count; i++) {
                    weights[i] = 1e-5 * (double)(i % 7);
                    for (k = 0; k < (size_t)dim; k++) {
                        const double size = own[(size_t)dim + k] - own[k], at = points[i * (size_t)dim + k];
                        points[i * (size_t)dim + k] = (axes >> k & 1) != 0 ? 3 * size * at
                                                                           : own[k] + size * (1.04 * at - 0.02);
                    }
                }
                compare_periodic(dim, points, NULL, count, own, axes, PBW_OK, dim == 2);
                compare_periodic(dim, points, weights, count, own, axes, PBW_OK, dim == 2);
                memset(&domain, 0, sizeof domain);
                domain.box = own;
                domain.periodic = axes;
                CHECK_EQUAL(pbw_cells_periodic(dim, points, weights, count, &domain, PBW_CELLS_FACETS, NULL, &cpu),
                            PBW_OK);
                CHECK_EQUAL(pbw_cuda_cells_of_host(dim, points, weights, count, own, axes, PBW_CUDA_FACETS, NULL,
                                                   pbw_triangulate, &made), PBW_OK);
                if (dim == 3) {
                    same_cells(&cpu, &made, 1);
                    CHECK(same(made.shifts, cpu.shifts, cpu.facet_count * (size_t)dim));
                }
                CHECK(same(made.sites, cpu.sites, count * (size_t)dim * sizeof(double)));
                pbw_cells_free(&cpu);
                pbw_cuda_cells_free(&made, NULL);
                compare_periodic(dim, points, NULL, count, own, axes | 8, PBW_ERROR_ARGUMENT, 0);
                compare_periodic(dim, points, NULL, count, own, 0, PBW_ERROR_ARGUMENT, 0);
                test_end();
            }
        }
    }
    free(points);
    free(weights);
}

/* Cells on several cards, or several times on one, are those of one card; fewer points than cards, too. */
static void test_cards(size_t count, int devices)
{
    double *points = (double *)zoo_grow(NULL, count * 3 * sizeof *points);
    double *weights = (double *)zoo_grow(NULL, count * sizeof *weights);
    const size_t counts[3] = { count, 5, 0 };
    int dim, cards, i;
    for (dim = 2; dim <= 3; dim++) {
        for (cards = 2; cards <= 6; cards += cards == 2 ? 1 : 3) {
            if (test_begin("cells: %dD on %d cards of %d", dim, cards, devices)) {
                const int list[6] = { 0, devices - 1, 0, devices - 1, 0, 0 };
                const double box[6] = { 0.1, 0.1, 0.1, 0.9, 0.9, 0.9 };
                pbw_options options;
                memset(&options, 0, sizeof options);
                options.backend = pbw_cuda_backend_multi(list, cards);
                input_fill(INPUT_UNIFORM, dim, count, (uint64_t)test_seed, points);
                input_fill_weights(INPUT_WEIGHTS_HIDING, dim, count, (uint64_t)test_seed, points, weights);
                for (i = 0; i < 12; i++) {
                    const double *w = i % 2 != 0 ? weights : NULL, *in = i % 4 < 2 ? box : NULL;
                    const unsigned facets = i % 3 != 0;
                    pbw_mesh mesh;
                    pbw_cells cpu;
                    pbw_cuda_cells gpu;
                    pbw_domain domain;
                    pbw_status expected;
                    memset(&domain, 0, sizeof domain);
                    domain.box = in;
                    expected = pbw_triangulate(dim, points, w, counts[i % 3], NULL, &mesh);
                    CHECK(expected == PBW_OK || expected == PBW_DEGENERATE);
                    expected = pbw_cells_of(&mesh, &domain, facets, NULL, &cpu);
                    CHECK_EQUAL(pbw_cuda_cells_of_host(dim, points, w, counts[i % 3], in, 0, facets, &options,
                                                       pbw_triangulate, &gpu), expected);
                    same_cells(&cpu, &gpu, 1);
                    pbw_cuda_cells_free(&gpu, NULL);
                    pbw_cells_free(&cpu);
                    pbw_free(&mesh);
                }
                test_end();
            }
        }
    }
    free(points);
    free(weights);
}

int main(int argc, char **argv)
{
    int devices = 0;
    size_t count = 6000;
    test_start(argc, argv, 1);
    if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) {
        printf("skipped: no CUDA device\n0 passed, 0 failed, 1 skipped\n");
        return 0;
    }
    pbw_cuda_patient = 1;
    pbw_cuda_piece = 4096;                      /* few points have many pieces */
    test_few();
    test_failures();
    test_loop(count);
    test_periodic(20000);
    test_walls(20000);
    test_cards(count, devices);
    test_zoo();
    test_kinds(count);
    return test_finish();
}
