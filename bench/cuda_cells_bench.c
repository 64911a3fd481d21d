/* cuda_cells_bench.c: cells by pbw_cuda.cu measured, and checked against pbw_cells.h in the same run

       build/cuda_cells_bench [--cpu N] [--runs N] [--steps N] [--cards N] [KIND:DIM:COUNT[:w] ...]

   cells      volumes and centroids in a box, from a mesh on the device to arrays there: best and median of the runs,
              their phases on the device, and the device memory of the call besides mesh and points, bytes a point
   facets     the same with neighbours and areas
   CPU        pbw_cells_of with all threads, once, for up to --cpu points (1e6): the arrays are equal, byte for byte,
              or the row says DIFFERENT and the exit status is 1
   all        from points on the device to volumes and centroids
   host       from arrays of the host to arrays of the host, on 1 to --cards cards (1): alone, then with facets
   periodic   the same in a box that repeats
   Lloyd      --steps steps of a loop (30; without weights): points to mesh to cells, centroids are the next points:
              median and worst step, and how much volumes differ from their mean, at first and at last
   The box: the unit cube for uniform points, else that of the points.  The first run of each warms up. */
#define _POSIX_C_SOURCE 200112L
#define PBW_CUDA
#include "../pbw.h"
#include "../examples/lib/pbw_cells.h"
#include "../tests/inputs.h"
#include <cuda_runtime_api.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { RUNS_MOST = 200 };

typedef struct bench { int runs, steps, cards, fault; size_t cpu_most; cudaMemPool_t pool; } bench;

typedef struct diagram {
    int dim;
    size_t count;
    double *points, *weights, box[6];
    pbw_cuda_points there;
    pbw_cuda_mesh mesh;
    pbw_options options;
    char message[256];
} diagram;

static double seconds(void)
{
    struct timespec now;
    cudaDeviceSynchronize();
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int same(const void *there, const void *here, size_t bytes)
{
    void *copy = malloc(bytes + 1);
    const int equal = copy != NULL && (there == NULL) == (here == NULL)
                   && (there == NULL || cudaMemcpy(copy, there, bytes, cudaMemcpyDeviceToHost) == cudaSuccess)
                   && (there == NULL || memcmp(copy, here, bytes) == 0);
    free(copy);
    return equal;
}

static int equal(const pbw_cells *cpu, const pbw_cuda_cells *gpu)
{
    const size_t count = cpu->cell_count;
    return gpu->cell_count == count && gpu->facet_count == cpu->facet_count
        && same(gpu->volumes, cpu->volumes, count * sizeof(double))
        && same(gpu->centroids, cpu->centroids, count * (size_t)cpu->dim * sizeof(double))
        && same(gpu->first, cpu->first, (count + 1) * sizeof(size_t))
        && same(gpu->neighbors, cpu->neighbors, cpu->facet_count * sizeof(pbw_index))
        && same(gpu->areas, cpu->areas, cpu->facet_count * sizeof(double));
}

static void compare(bench *b, const diagram *d, const pbw_mesh *mesh, unsigned facets, const pbw_cuda_cells *gpu)
{
    pbw_domain domain;
    pbw_cells cells;
    double start = seconds();
    memset(&domain, 0, sizeof domain);
    domain.box = d->box;
    if (pbw_cells_of(mesh, &domain, facets != 0 ? PBW_CELLS_FACETS : 0, NULL, &cells) == PBW_OK) {
        const double time = seconds() - start;
        const int good = equal(&cells, gpu);
        printf("  CPU       %.2f ms: %s\n", 1e3 * time, good ? "equal" : "DIFFERENT");
        b->fault |= !good;
    }
    pbw_cells_free(&cells);
}

static void cells_row(bench *b, diagram *d, unsigned facets, const pbw_mesh *mesh)
{
    double times[RUNS_MOST], start;
    uint64_t none = 0, before = 0, most = 0;
    pbw_cuda_cells cells;
    pbw_status status = PBW_OK;
    int run, i;
    cudaMemPoolSetAttribute(b->pool, cudaMemPoolAttrUsedMemHigh, &none);
    cudaMemPoolGetAttribute(b->pool, cudaMemPoolAttrUsedMemCurrent, &before);
    for (run = 0; run <= b->runs && status == PBW_OK; run++) {
        start = seconds();
        status = pbw_cuda_cells_of(&d->mesh, &d->there, d->box, facets, &d->options, NULL, pbw_triangulate, &cells);
        times[run > 0 ? run - 1 : 0] = seconds() - start;
        if (run < b->runs) {
            pbw_cuda_cells_free(&cells, NULL);
        }
    }
    if (status != PBW_OK) {
        printf("  cells     %s: %s\n", pbw_status_string(status), d->message);
        b->fault = 1;
        return;
    }
    cudaMemPoolGetAttribute(b->pool, cudaMemPoolAttrUsedMemHigh, &most);
    qsort(times, (size_t)b->runs, sizeof times[0], compare_doubles);
    printf("  %s    best %.2f median %.2f ms; %.0f device bytes a point; ", facets != 0 ? "facets" : "cells ",
           1e3 * times[0], 1e3 * times[b->runs / 2], (double)(most - before) / (double)d->count);
    for (i = 0; i < 5; i++) {
        printf(" %.2f", (double)cells.milliseconds[i]);
    }
    printf("\n");
    if (mesh != NULL) {
        compare(b, d, mesh, facets, &cells);
    }
    pbw_cuda_cells_free(&cells, NULL);
}

static void all_row(bench *b, diagram *d)
{
    double times[RUNS_MOST], start;
    pbw_cuda_mesh mesh;
    pbw_cuda_cells cells;
    int run;
    for (run = 0; run < b->runs; run++) {
        start = seconds();
        b->fault |= pbw_cuda_triangulate(d->dim, 0, d->there.points, d->there.weights, d->count, &d->options, NULL,
                                         pbw_triangulate, &mesh) != PBW_OK
                 || pbw_cuda_cells_of(&mesh, &d->there, d->box, 0, &d->options, NULL, NULL, &cells) != PBW_OK;
        times[run] = seconds() - start;
        pbw_cuda_cells_free(&cells, NULL);
        pbw_cuda_free(&mesh, NULL);
    }
    qsort(times, (size_t)b->runs, sizeof times[0], compare_doubles);
    printf("  all       best %.2f median %.2f ms\n", 1e3 * times[0], 1e3 * times[b->runs / 2]);
}

/* Several cards have the bytes of one, or the row says DIFFERENT. */
static void host_row(bench *b, diagram *d, unsigned facets)
{
    const double *weights = d->there.weights != NULL ? d->weights : NULL;
    int list[16], cards, run;
    pbw_cuda_cells one;
    memset(&one, 0, sizeof one);
    for (cards = 1; cards <= b->cards; cards++) {
        double times[RUNS_MOST], start;
        int good = 1;
        pbw_options options = d->options;
        list[cards - 1] = cards - 1;
        options.backend = pbw_cuda_backend_multi(list, cards);
        for (run = 0; run <= b->runs; run++) {
            pbw_cuda_cells cells;
            start = seconds();
            b->fault |= pbw_cuda_cells_of_host(d->dim, d->points, weights, d->count, d->box, 0, facets, &options,
                                               pbw_triangulate, &cells) != PBW_OK;
            times[run > 0 ? run - 1 : 0] = seconds() - start;
            if (cards == 1 && run == b->runs) {
                one = cells;
                continue;
            }
            good &= cards == 1 || (cells.facet_count == one.facet_count
                                   && memcmp(cells.volumes, one.volumes, d->count * sizeof(double)) == 0
                                   && memcmp(cells.centroids, one.centroids,
                                             d->count * (size_t)d->dim * sizeof(double)) == 0
                                   && (facets == 0
                                       || (memcmp(cells.first, one.first, (d->count + 1) * sizeof(size_t)) == 0
                                           && memcmp(cells.neighbors, one.neighbors,
                                                     one.facet_count * sizeof(pbw_index)) == 0
                                           && memcmp(cells.areas, one.areas,
                                                     one.facet_count * sizeof(double)) == 0)));
            pbw_cuda_cells_free(&cells, NULL);
        }
        qsort(times, (size_t)b->runs, sizeof times[0], compare_doubles);
        printf("  host%s, %d card%s: best %.2f median %.2f ms%s\n", facets != 0 ? ", facets" : "", cards,
               cards > 1 ? "s" : "", 1e3 * times[0], 1e3 * times[b->runs / 2], good ? "" : " DIFFERENT");
        b->fault |= !good;
    }
    pbw_cuda_cells_free(&one, NULL);
}

static void periodic_row(bench *b, diagram *d)
{
    double times[RUNS_MOST], start;
    pbw_cuda_cells cells;
    pbw_status status = PBW_OK;
    int run;
    for (run = 0; run < b->runs && status == PBW_OK; run++) {
        start = seconds();
        status = pbw_cuda_cells_periodic(&d->there, d->box, (1u << d->dim) - 1, 0, &d->options, NULL,
                                         pbw_triangulate, &cells);
        times[run] = seconds() - start;
        pbw_cuda_cells_free(&cells, NULL);
    }
    if (status != PBW_OK) {
        printf("  periodic  %s: %s\n", pbw_status_string(status), d->message);
        return;
    }
    qsort(times, (size_t)b->runs, sizeof times[0], compare_doubles);
    printf("  periodic  best %.2f median %.2f ms\n", 1e3 * times[0], 1e3 * times[b->runs / 2]);
}

/* The standard deviation of volumes, in parts of their mean. */
static double spread(const diagram *d, const pbw_cuda_cells *cells)
{
    double *volumes = (double *)malloc(d->count * sizeof(double)), sum = 0, squares = 0, mean;
    size_t i;
    if (volumes == NULL || cudaMemcpy(volumes, cells->volumes, d->count * sizeof(double), cudaMemcpyDeviceToHost)
                           != cudaSuccess) {
        free(volumes);
        return -1;
    }
    for (i = 0; i < d->count; i++) {
        sum += volumes[i];
        squares += volumes[i] * volumes[i];
    }
    mean = sum / (double)d->count;
    free(volumes);
    return sqrt(fmax(squares / (double)d->count - mean * mean, 0)) / mean;
}

static void lloyd_row(bench *b, diagram *d)
{
    double times[RUNS_MOST], start, before = 0, parts[2] = { 0, 0 };
    pbw_cuda_points at = d->there;
    pbw_cuda_loop *loop = NULL;
    pbw_cuda_mesh mesh;
    pbw_cuda_cells cells;
    int step, worst = 0, steps = b->steps;
    memset(&cells, 0, sizeof cells);
    at.rebuild = 1;
    b->fault |= pbw_cuda_loop_create(&d->options, NULL, pbw_triangulate, &loop) != PBW_OK;
    for (step = 0; step < steps; step++) {
        start = seconds();
        b->fault |= pbw_cuda_loop_step(loop, &at, &mesh) != PBW_OK
                 || pbw_cuda_loop_cells(loop, &at, d->box, 0, &cells) != PBW_OK;
        times[step] = seconds() - start;
        if (step > 0) {                              /* the first one takes the memory */
            worst = worst == 0 || times[step] > times[worst] ? step : worst;
        } else {
            before = spread(d, &cells);
        }
        if (step == worst) {
            parts[0] = (double)mesh.milliseconds[7];
            parts[1] = (double)mesh.milliseconds[3];
        }
        at.points = cells.centroids;
    }
    if (steps > 1) {
        const double most = times[worst];
        const double after = spread(d, &cells);
        qsort(times + 1, (size_t)steps - 1, sizeof times[0], compare_doubles);
        printf("  Lloyd     first %.2f median %.2f worst %.2f ms (step %d: mesh %.2f, far %.2f); "
               "spread %.3f to %.3f\n", 1e3 * times[0], 1e3 * times[1 + (steps - 1) / 2], 1e3 * most, worst, parts[0],
               parts[1], before, after);
    }
    pbw_cuda_loop_free(loop);
}

static void row(bench *b, diagram *d, int kind, int weighted)
{
    const size_t numbers = d->count * (size_t)d->dim;
    void *points = NULL, *weights = NULL;
    pbw_mesh mesh;
    size_t i;
    int k;
    input_fill(kind, d->dim, d->count, 1, d->points);
    if (weighted) {
        input_fill_weights(INPUT_WEIGHTS_HIDING, d->dim, d->count, 1, d->points, d->weights);
    }
    for (k = 0; k < d->dim; k++) {
        double *low = d->box + k, *high = d->box + d->dim + k;
        *low = kind == INPUT_UNIFORM ? 0 : d->points[k];
        *high = kind == INPUT_UNIFORM ? 1 : d->points[k];
        for (i = (size_t)k; i < numbers && kind != INPUT_UNIFORM; i += (size_t)d->dim) {
            *low = d->points[i] < *low ? d->points[i] : *low;
            *high = d->points[i] > *high ? d->points[i] : *high;
        }
    }
    memset(&mesh, 0, sizeof mesh);
    b->fault |= cudaMalloc(&points, numbers * sizeof(double)) != cudaSuccess
             || cudaMalloc(&weights, d->count * sizeof(double)) != cudaSuccess
             || cudaMemcpy(points, d->points, numbers * sizeof(double), cudaMemcpyHostToDevice) != cudaSuccess
             || cudaMemcpy(weights, d->weights, d->count * sizeof(double), cudaMemcpyHostToDevice) != cudaSuccess;
    d->there.dim = d->dim;
    d->there.count = d->count;
    d->there.points = points;
    d->there.weights = weighted ? weights : NULL;
    b->fault |= pbw_cuda_triangulate(d->dim, 0, points, d->there.weights, d->count, &d->options, NULL,
                                     pbw_triangulate, &d->mesh) != PBW_OK;
    printf("  mesh      %.2f ms on the device%s\n", (double)d->mesh.milliseconds[7],
           d->mesh.by_cpu ? ", by the CPU" : "");
    if (d->count <= b->cpu_most) {
        b->fault |= pbw_triangulate(d->dim, d->points, weighted ? d->weights : NULL, d->count, NULL, &mesh) != PBW_OK;
    }
    cells_row(b, d, 0, mesh.simplex_count > 0 ? &mesh : NULL);
    cells_row(b, d, PBW_CUDA_FACETS, mesh.simplex_count > 0 ? &mesh : NULL);
    pbw_cuda_free(&d->mesh, NULL);
    pbw_free(&mesh);
    all_row(b, d);
    host_row(b, d, 0);
    host_row(b, d, PBW_CUDA_FACETS);
    periodic_row(b, d);
    if (!weighted) {
        lloyd_row(b, d);
    }
    cudaFree(points);
    cudaFree(weights);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static const char *const usual[] = { "uniform:3:1000000", "uniform:3:10000000", "uniform:3:1000000:w",
                                         "terrain:3:200000", "lattice:3:1000000", "clusters:3:1000000",
                                         "uniform:2:1000000", "uniform:2:10000000" };
    const char *const *rows = usual;
    int i, k, row_count = (int)(sizeof usual / sizeof usual[0]);
    uint64_t keep = UINT64_MAX;
    struct cudaDeviceProp properties;
    bench b = { 5, 30, 1, 0, 1000000, NULL };
    for (i = 1; i + 1 < argc && argv[i][0] == '-'; i += 2) {
        const double number = atof(argv[i + 1]);
        if (strcmp(argv[i], "--cpu") == 0) {
            b.cpu_most = (size_t)number;
        } else {
            const int most = strcmp(argv[i], "--cards") == 0 ? 16 : RUNS_MOST;
            *(strcmp(argv[i], "--runs") == 0 ? &b.runs : most == 16 ? &b.cards : &b.steps)
                = (int)fmin(fmax(number, 1), most);
        }
    }
    if (cudaGetDeviceProperties(&properties, 0) != cudaSuccess
        || cudaDeviceGetDefaultMemPool(&b.pool, 0) != cudaSuccess) {
        printf("skipped: no CUDA device\n");
        return 0;
    }
    for (k = 0; k < b.cards; k++) {                  /* pools keep their memory */
        cudaMemPool_t pool;
        b.fault |= cudaDeviceGetDefaultMemPool(&pool, k) != cudaSuccess
                || cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &keep) != cudaSuccess;
    }
    printf("%s\n", properties.name);
    if (i < argc) {
        rows = (const char *const *)argv + i;
        row_count = argc - i;
    }
    for (i = 0; i < row_count; i++) {
        diagram d;
        char name[32], weights = 0;
        double count = 0;
        int kind;
        memset(&d, 0, sizeof d);
        d.options.message = d.message;
        d.options.message_size = sizeof d.message;
        if (sscanf(rows[i], "%31[^:]:%d:%lf:%c", name, &d.dim, &count, &weights) < 3) {
            printf("%s: not KIND:DIM:COUNT[:w]\n", rows[i]);
            return 2;
        }
        d.count = (size_t)count;
        d.points = (double *)malloc(d.count * (size_t)d.dim * sizeof(double));
        d.weights = (double *)calloc(d.count, sizeof(double));
        for (kind = 0; kind < INPUT_KINDS && strcmp(name, input_name(kind)) != 0; kind++) {
        }
        if (kind == INPUT_KINDS || d.points == NULL || d.weights == NULL) {
            printf("%s: no such kind, or out of memory\n", rows[i]);
            return 2;
        }
        printf("%s%s %dD %lu\n", name, weights != 0 ? " weighted" : "", d.dim, (unsigned long)d.count);
        row(&b, &d, kind, weights == 'w');
        free(d.points);
        free(d.weights);
    }
    return b.fault;
}
