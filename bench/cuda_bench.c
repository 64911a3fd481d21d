/* cuda_bench.c: pbw_cuda.cu measured, and checked against the CPU in the same run

       build/cuda_bench [--quick] [--cpu N] [--runs N] [--cards N] [[loop:]KIND:DIM:COUNT[:w] ...]

   device     from points on the device to arrays on the device: best and median of the runs, and its phases
   check      pbw_cuda_check of the result; a fault makes the exit status 1
   host       pbw_triangulate with the backend, from host memory to host memory: the same.  Points and results are in
              pinned blocks that were touched before, which options.resize hands out again
   pageable   the same from malloc'd points to malloc'd arrays, which are new to the process in each run
   cards      the same by a team of --cards devices, the devices there are in turn: its arrays equal those of one, and
              its time is compared with that of one
   CPU        pbw_triangulate without the backend on all threads, once, for up to --cpu points (1e6): the arrays are
              equal, byte for byte, or the row says DIFFERENT and the exit status is 1
   The first run of each row warms up and is not counted.  Memory stays in the device's pool between runs.
   loop       points that move: all step by up to a part of an edge (the side of the cube that a point has for
              itself), or turn by 90 degrees, which keeps the mesh in another order.  --runs steps of each: best and
              median with the test of the mesh before, without it (untested), and by pbw_cuda_triangulate (fresh); how
              many steps kept the mesh.  Every mesh equals that of pbw_cuda_triangulate, byte for byte, or the exit
              status is 1.  First, a call that gives all device memory back, as CUDA's pools do by default. */
#define _POSIX_C_SOURCE 200112L
#define PBW_CUDA
#include "../pbw.h"
#include "../tests/inputs.h"
#include <cuda_runtime_api.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define RUNS_MOST 100

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- an allocator that keeps its blocks, pinned; threads of the CPU share it */
typedef struct block { void *address; size_t bytes; int busy; } block;
typedef struct keeper { block blocks[1024]; int count; pthread_mutex_t lock; } keeper;

static void *keeper_resize_alone(keeper *k, void *address, size_t old_bytes, size_t bytes)
{
    int i, best = -1;
    void *fresh;
    if (bytes > 0) {
        for (i = 0; i < k->count; i++) {
            if (!k->blocks[i].busy && k->blocks[i].bytes >= bytes
                && (best < 0 || k->blocks[i].bytes < k->blocks[best].bytes)) {
                best = i;
            }
        }
        if (best < 0) {
            if (k->count == 1024 || cudaMallocHost(&fresh, bytes) != cudaSuccess) {
                return NULL;
            }
            memset(fresh, 1, bytes);
            best = k->count++;
            k->blocks[best].address = fresh;
            k->blocks[best].bytes = bytes;
        }
        k->blocks[best].busy = 1;
        if (address != NULL) {
            memcpy(k->blocks[best].address, address, old_bytes < bytes ? old_bytes : bytes);
        }
    }
    for (i = 0; i < k->count; i++) {
        if (address != NULL && k->blocks[i].address == address) {
            k->blocks[i].busy = 0;
        }
    }
    return bytes > 0 ? k->blocks[best].address : NULL;
}

static void *keeper_resize(void *user, void *address, size_t old_bytes, size_t bytes)
{
    keeper *k = (keeper *)user;
    void *result;
    pthread_mutex_lock(&k->lock);
    result = keeper_resize_alone(k, address, old_bytes, bytes);
    pthread_mutex_unlock(&k->lock);
    return result;
}

/* When the CPU, which takes memory first, took over from a backend that has said why. */
typedef struct watch { keeper *memory; const char *message; double over; } watch;

static void *watch_resize(void *user, void *address, size_t old_bytes, size_t bytes)
{
    watch *w = (watch *)user;
    if (w->over == 0.0 && w->message[0] != '\0') {
        w->over = seconds();
    }
    return keeper_resize(w->memory, address, old_bytes, bytes);
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int equal(const pbw_mesh *a, const pbw_mesh *b)
{
    size_t links = a->simplex_count * ((size_t)a->dim + 1) * sizeof(pbw_index);
    size_t each = a->point_count * sizeof(pbw_index);
    return a->simplex_count == b->simplex_count && a->hidden_count == b->hidden_count
        && a->duplicate_count == b->duplicate_count && memcmp(a->simplices, b->simplices, links) == 0
        && memcmp(a->neighbors, b->neighbors, links) == 0 && memcmp(a->incident, b->incident, each) == 0
        && memcmp(a->canonical, b->canonical, each) == 0;
}

/* Host to host, runs times after one to warm up: sorted times; whether the backend made the mesh. */
static pbw_status host_to_host(int dim, const double *points, const double *weights, size_t count,
                               const pbw_options *options, int runs, double *times, pbw_mesh *mesh)
{
    pbw_status status = PBW_OK;
    int run;
    for (run = 0; run <= runs && status == PBW_OK; run++) {
        double start = seconds();
        pbw_free(mesh);
        start = seconds();
        status = pbw_triangulate(dim, points, weights, count, options, mesh);
        times[run > 0 ? run - 1 : 0] = seconds() - start;
        if (!mesh->statistics.by_backend) {
            return status;
        }
    }
    qsort(times, (size_t)runs, sizeof times[0], compare_doubles);
    return status;
}

static int row(const char *kind_name, int dim, size_t count, int weighted, int runs, size_t cpu_most, int cards,
               keeper *memory)
{
    static const char *const phase[8] = { "order", "boxes", "near", "far", "count", "simplices", "neighbors", "all" };
    int kind, run, i, fault = 0, by_backend = 0;
    double times[RUNS_MOST], *points, *weights = NULL;
    void *points_on_device = NULL, *weights_on_device = NULL;
    char message[256] = "";
    pbw_options options;
    pbw_mesh mesh;
    pbw_cuda_mesh device_mesh;
    pbw_status status = PBW_OK;
    size_t point_bytes = count * (size_t)dim * sizeof(double), simplices = 0, free_before, free_after, all;
    for (kind = 0; kind < INPUT_KINDS && strcmp(kind_name, input_name(kind)) != 0; kind++) {
    }
    if (kind == INPUT_KINDS || cudaMallocHost((void **)&points, point_bytes) != cudaSuccess
        || (weighted && cudaMallocHost((void **)&weights, count * sizeof(double)) != cudaSuccess)) {
        printf("%s: no such kind, or out of memory\n", kind_name);
        return 1;
    }
    input_fill(kind, dim, count, 1, points);
    if (weighted) {
        input_fill_weights(INPUT_WEIGHTS_HIDING, dim, count, 1, points, weights);
    }
    memset(&options, 0, sizeof options);
    options.message = message;
    options.message_size = sizeof message;
    memset(&mesh, 0, sizeof mesh);
    printf("%s%s %dD %zu\n", kind_name, weighted ? " weighted" : "", dim, count);

    cudaMemGetInfo(&free_before, &all);
    if (cudaMalloc(&points_on_device, point_bytes) == cudaSuccess
        && (!weighted || cudaMalloc(&weights_on_device, count * sizeof(double)) == cudaSuccess)) {
        cudaMemcpy(points_on_device, points, point_bytes, cudaMemcpyHostToDevice);
        if (weighted) {
            cudaMemcpy(weights_on_device, weights, count * sizeof(double), cudaMemcpyHostToDevice);
        }
        for (run = 0; run <= runs && (status == PBW_OK || run == 1); run++) {
            double start;
            cudaDeviceSynchronize();
            start = seconds();
            status = pbw_cuda_triangulate(dim, 0, points_on_device, weights_on_device, count, &options, NULL,
                                          pbw_triangulate, &device_mesh);
            cudaDeviceSynchronize();
            times[run > 0 ? run - 1 : 0] = seconds() - start;
            if (status == PBW_OK && run == runs) {
                cudaMemGetInfo(&free_after, &all);
                simplices = device_mesh.simplex_count;
                qsort(times, (size_t)runs, sizeof times[0], compare_doubles);
                printf("  device    %sbest %.2f median %.2f ms; %zu simplices; stars %zu, %zu, %zu; "
                       "%.0f device bytes a point\n   ", device_mesh.by_cpu ? "by the CPU: " : "", 1e3 * times[0],
                       1e3 * times[runs / 2], simplices, device_mesh.stars[0], device_mesh.stars[1],
                       device_mesh.stars[2], (double)(free_before - free_after) / (double)count);
                for (i = 0; i < 8; i++) {
                    printf(" %s %.2f", phase[i], (double)device_mesh.milliseconds[i]);
                }
                printf("\n");
            }
            if (status == PBW_OK && run == runs) {
                pbw_report report;
                start = seconds();
                status = pbw_cuda_check(&device_mesh, 0, points_on_device, weights_on_device, &options, NULL,
                                        &report);
                printf("  check     %.2f ms: %s\n", 1e3 * (seconds() - start),
                       status != PBW_OK ? message : report.valid ? "sound" : report.what);
                fault |= status != PBW_OK || !report.valid;
            }
            pbw_cuda_free(&device_mesh, NULL);
        }
    }
    if (status != PBW_OK) {
        printf("  device    %s after %.2f ms: %s\n", pbw_status_string(status), 1e3 * times[0], message);
    }
    cudaFree(points_on_device);
    cudaFree(weights_on_device);

    options.backend = pbw_cuda_backend(0);
    options.resize = keeper_resize;
    options.resize_user = memory;
    status = host_to_host(dim, points, weights, count, &options, runs, times, &mesh);
    by_backend = mesh.statistics.by_backend;
    if (status == PBW_OK && by_backend) {
        printf("  host      best %.2f median %.2f ms, pinned and touched\n", 1e3 * times[0], 1e3 * times[runs / 2]);
    } else {
        watch taken = { memory, message, 0.0 };
        double start;
        pbw_free(&mesh);
        message[0] = '\0';
        options.resize = watch_resize;
        options.resize_user = &taken;
        options.threads = 1;                         /* others would look at the clock at once */
        start = seconds();
        status = pbw_triangulate(dim, points, weights, count, &options, &mesh);
        start = (taken.over > 0.0 ? taken.over : seconds()) - start;
        printf("  host      %s, %s after %.2f ms: %s\n", pbw_status_string(status),
               by_backend ? "GPU" : "by the CPU", 1e3 * start, message);
        pbw_free(&mesh);
        options.threads = 0;
        options.resize = keeper_resize;
        options.resize_user = memory;
        fault |= status != PBW_OK;
    }
    fflush(stdout);
    if (cards > 1) {
        int device[16], devices = 1;
        double team_times[RUNS_MOST];
        pbw_mesh other;
        memset(&other, 0, sizeof other);
        cudaGetDeviceCount(&devices);
        for (i = 0; i < cards; i++) {
            device[i] = i % devices;
        }
        options.backend = pbw_cuda_backend_multi(device, cards);
        message[0] = '\0';
        status = host_to_host(dim, points, weights, count, &options, runs, team_times, &other);
        printf("  cards     %d on %d devices: ", cards, cards < devices ? cards : devices);
        if (status == PBW_OK && other.statistics.by_backend) {
            int same = by_backend && equal(&mesh, &other);
            printf("best %.2f median %.2f ms, %.2f times one: %s\n", 1e3 * team_times[0],
                   1e3 * team_times[runs / 2], times[0] / team_times[0],
                   same ? "equal" : by_backend ? "DIFFERENT" : "no mesh to compare with");
            fault |= by_backend && !same;
        } else {
            printf("%s: %s\n", pbw_status_string(status), message);
            fault |= status != PBW_OK;
        }
        pbw_free(&other);
        status = by_backend ? PBW_OK : status;
        options.backend = pbw_cuda_backend(0);
    }
    if (status == PBW_OK && by_backend && count <= 20000000) {
        const size_t weight_bytes = weighted ? count * sizeof(double) : 0;
        double *ordinary = (double *)malloc(point_bytes + weight_bytes), start, gpu = times[0];
        pbw_mesh other;
        memset(&other, 0, sizeof other);
        options.resize = NULL;
        if (ordinary != NULL) {
            double *const last = ordinary + count * (size_t)dim;
            memcpy(ordinary, points, point_bytes);
            memcpy(last, weighted ? weights : points, weight_bytes);
            status = host_to_host(dim, ordinary, weighted ? last : NULL, count, &options, runs, times, &other);
            printf("  pageable  best %.2f median %.2f ms: %s\n", 1e3 * times[0], 1e3 * times[runs / 2],
                   status == PBW_OK && equal(&mesh, &other) ? "equal" : "DIFFERENT");
            fault |= status != PBW_OK || !equal(&mesh, &other);
        }
        pbw_free(&other);
        free(ordinary);
        if (count <= cpu_most) {
            int same;
            options.backend = NULL;
            start = seconds();
            status = pbw_triangulate(dim, points, weights, count, &options, &other);
            start = seconds() - start;
            same = status == PBW_OK && equal(&mesh, &other);
            printf("  CPU       %.2f ms, %.1f times the host time above: %s\n", 1e3 * start, start / gpu,
                   same ? "equal" : "DIFFERENT");
            fault |= !same;
            pbw_free(&other);
        }
    }
    pbw_free(&mesh);
    cudaFreeHost(points);
    cudaFreeHost(weights);
    fflush(stdout);
    return fault;
}

/* ---- points that move */
typedef struct moving {
    int dim, weighted;
    size_t count;
    double *points, *weights;
    void *there, *weights_there;
    pbw_options options;
    char message[256];
} moving;

/* Steps all points by up to a part of an edge; a negative part is a quarter turn about the last axis. */
static int move_all(moving *m, double part, uint64_t *state)
{
    const double edge = pow((double)m->count, -1.0 / m->dim);
    size_t i;
    for (i = 0; i < m->count * (size_t)m->dim && part >= 0.0; i++) {
        m->points[i] += 2.0 * part * edge * (input_uniform(state) - 0.5);
    }
    for (i = 0; i < m->count * (size_t)m->dim && part < 0.0; i += (size_t)m->dim) {
        const double x = m->points[i];
        m->points[i] = -m->points[i + 1];
        m->points[i + 1] = x;
    }
    return cudaMemcpy(m->there, m->points, m->count * (size_t)m->dim * sizeof(double), cudaMemcpyHostToDevice)
           == cudaSuccess;
}

static int same_on_device(const pbw_index *a, const pbw_index *b, size_t count)
{
    const size_t bytes = count * sizeof *a;
    char *copy = (char *)malloc(2 * bytes + 1);
    int same = copy != NULL && cudaMemcpy(copy, a, bytes, cudaMemcpyDeviceToHost) == cudaSuccess
            && cudaMemcpy(copy + bytes, b, bytes, cudaMemcpyDeviceToHost) == cudaSuccess
            && memcmp(copy, copy + bytes, bytes) == 0;
    free(copy);
    return same;
}

static int equal_on_device(const pbw_cuda_mesh *a, const pbw_cuda_mesh *b)
{
    const size_t links = a->simplex_count * ((size_t)a->dim + 1);
    return a->dim == b->dim && a->point_count == b->point_count && a->simplex_count == b->simplex_count
        && a->hidden_count == b->hidden_count && a->duplicate_count == b->duplicate_count
        && same_on_device(a->simplices, b->simplices, links) && same_on_device(a->neighbors, b->neighbors, links)
        && same_on_device(a->incident, b->incident, a->point_count)
        && same_on_device(a->canonical, b->canonical, a->point_count);
}

static pbw_status fresh_step(moving *m, pbw_cuda_mesh *mesh, double *time)
{
    pbw_status status;
    double start;
    cudaDeviceSynchronize();
    start = seconds();
    status = pbw_cuda_triangulate(m->dim, 0, m->there, m->weights_there, m->count, &m->options, NULL,
                                  pbw_triangulate, mesh);
    cudaDeviceSynchronize();
    *time = seconds() - start;
    return status;
}

static pbw_status loop_step(moving *m, pbw_cuda_loop *loop, int rebuild, pbw_cuda_mesh *mesh, double *time)
{
    pbw_cuda_points in;
    pbw_status status;
    double start;
    memset(&in, 0, sizeof in);
    in.dim = m->dim;
    in.points = m->there;
    in.weights = m->weights_there;
    in.count = m->count;
    in.rebuild = rebuild;
    cudaDeviceSynchronize();
    start = seconds();
    status = pbw_cuda_loop_step(loop, &in, mesh);
    cudaDeviceSynchronize();
    *time = seconds() - start;
    return status;
}

/* Prints the times of steps with one size of moves; a fault is 1. */
static int loop_steps(moving *m, pbw_cuda_loop *loop, double part, int runs)
{
    static const char *const way[3] = { "tested", "untested", "fresh" };
    double times[3][RUNS_MOST];
    uint64_t state = 7;
    int run, i, kept = 0, fault = 0;
    for (run = 0; run < runs && !fault; run++) {
        pbw_cuda_mesh mesh, fresh;
        fault = !move_all(m, part, &state) || loop_step(m, loop, 0, &mesh, &times[0][run]) != PBW_OK;
        kept += mesh.kept;
        fault = fault || fresh_step(m, &fresh, &times[2][run]) != PBW_OK || !equal_on_device(&mesh, &fresh);
        fault = fault || loop_step(m, loop, 1, &mesh, &times[1][run]) != PBW_OK || !equal_on_device(&mesh, &fresh);
        pbw_cuda_free(&fresh, NULL);
    }
    if (part < 0.0) {
        printf("  a quarter turn        kept %d of %d", kept, runs);
    } else {
        printf("  moves by up to %-6g kept %d of %d", part, kept, runs);
    }
    for (i = 0; i < 3 && !fault; i++) {
        qsort(times[i], (size_t)runs, sizeof times[i][0], compare_doubles);
        printf("; %s best %.2f median %.2f ms", way[i], 1e3 * times[i][0], 1e3 * times[i][runs / 2]);
    }
    printf("; %s\n", fault ? m->message[0] != '\0' ? m->message : "DIFFERENT" : "equal");
    return fault;
}

static int loop_row(const char *kind_name, int dim, size_t count, int weighted, int runs)
{
    static const double parts[5] = { 1e-10, -1.0, 1e-3, 0.03, 0.5 };
    uint64_t none = 0, all = UINT64_MAX;
    int kind, i, fault = 0;
    double time = 0.0, first = 0.0;
    cudaMemPool_t pool;
    pbw_cuda_loop *loop = NULL;
    pbw_cuda_mesh mesh;
    moving m;
    memset(&m, 0, sizeof m);
    for (kind = 0; kind < INPUT_KINDS && strcmp(kind_name, input_name(kind)) != 0; kind++) {
    }
    m.dim = dim;
    m.count = count;
    m.options.message = m.message;
    m.options.message_size = sizeof m.message;
    m.points = (double *)malloc(count * (size_t)dim * sizeof(double));
    m.weights = (double *)malloc(count * sizeof(double));
    if (kind == INPUT_KINDS || m.points == NULL || m.weights == NULL
        || cudaMalloc(&m.there, count * (size_t)dim * sizeof(double)) != cudaSuccess
        || (weighted && cudaMalloc(&m.weights_there, count * sizeof(double)) != cudaSuccess)
        || cudaDeviceGetDefaultMemPool(&pool, 0) != cudaSuccess
        || pbw_cuda_loop_create(&m.options, NULL, pbw_triangulate, &loop) != PBW_OK) {
        printf("%s: no such kind, or out of memory\n", kind_name);
        return 1;
    }
    input_fill(kind, dim, count, 1, m.points);
    if (weighted) {
        input_fill_weights(INPUT_WEIGHTS_HIDING, dim, count, 1, m.points, m.weights);
        cudaMemcpy(m.weights_there, m.weights, count * sizeof(double), cudaMemcpyHostToDevice);
    }
    fault = !move_all(&m, 0.0, &none);
    none = 0;
    cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &none);
    for (i = 0; i < 3 && !fault; i++) {
        fault = fresh_step(&m, &mesh, &time) != PBW_OK;
        first = i == 0 || time < first ? time : first;
        pbw_cuda_free(&mesh, NULL);
        cudaDeviceSynchronize();
    }
    cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &all);
    printf("loop %s%s %dD %zu: a call that gives its memory back %.2f ms\n", kind_name, weighted ? " weighted" : "",
           dim, count, 1e3 * first);
    fault = fault || fresh_step(&m, &mesh, &time) != PBW_OK;
    pbw_cuda_free(&mesh, NULL);
    fault = fault || loop_step(&m, loop, 0, &mesh, &time) != PBW_OK;
    for (i = 0; i < 5 && !fault; i++) {
        fault = loop_steps(&m, loop, parts[i], runs);
        fflush(stdout);
    }
    pbw_cuda_loop_free(loop);
    cudaFree(m.there);
    cudaFree(m.weights_there);
    free(m.points);
    free(m.weights);
    return fault;
}

int main(int argc, char **argv)
{
    static const char *const quick[] = {
        "uniform:3:1000000", "uniform:2:1000000", "uniform:3:1000000:w", "loop:uniform:3:1000000"
    };
    static const char *const usual[] = {
        "uniform:3:1000000", "uniform:3:10000000", "gauss:3:1000000", "ball:3:1000000", "clusters:3:1000000",
        "sphere:3:200000", "terrain:3:1000000", "lattice:3:1000000", "uniform:3:1000000:w", "uniform:2:1000000",
        "uniform:2:10000000", "uniform:2:1000000:w", "lattice:2:1000000", "loop:uniform:3:1000000",
        "loop:uniform:2:1000000", "loop:uniform:3:1000000:w"
    };
    const char *const *rows = usual;
    int i, runs = 5, fault = 0, device = 0, cards = 1, row_count = (int)(sizeof usual / sizeof usual[0]);
    size_t cpu_most = 1000000;
    cudaMemPool_t pool;
    uint64_t keep = UINT64_MAX;
    static keeper memory;
    struct cudaDeviceProp properties;
    pthread_mutex_init(&memory.lock, NULL);
    for (i = 1; i < argc && argv[i][0] == '-'; i++) {
        if (strcmp(argv[i], "--quick") == 0) {
            rows = quick;
            row_count = (int)(sizeof quick / sizeof quick[0]);
        } else if (i + 1 < argc && strcmp(argv[i], "--cpu") == 0) {
            cpu_most = (size_t)strtod(argv[++i], NULL);
        } else if (i + 1 < argc && strcmp(argv[i], "--cards") == 0) {
            cards = atoi(argv[++i]);
            cards = cards < 1 ? 1 : cards > 16 ? 16 : cards;
        } else if (i + 1 < argc && strcmp(argv[i], "--runs") == 0) {
            runs = atoi(argv[++i]);
            runs = runs < 1 ? 1 : runs > RUNS_MOST ? RUNS_MOST : runs;
        } else {
            printf("usage: cuda_bench [--quick] [--cpu N] [--runs N] [--cards N] [[loop:]KIND:DIM:COUNT[:w] ...]\n");
            return 2;
        }
    }
    if (cudaGetDeviceProperties(&properties, device) != cudaSuccess) {
        printf("skipped: no CUDA device\n");
        return 0;
    }
    printf("%s, compute capability %d.%d, %d multiprocessors, %.0f MB\n", properties.name, properties.major,
           properties.minor, properties.multiProcessorCount, (double)properties.totalGlobalMem * 1e-6);
    fflush(stdout);
    if (i < argc) {
        rows = (const char *const *)argv + i;
        row_count = argc - i;
    }
    if (system("nvidia-smi --query-gpu=clocks.sm,clocks.mem,temperature.gpu,power.draw --format=csv,noheader") != 0) {
        printf("clocks unknown\n");
    }
    for (device = 0; cudaDeviceGetDefaultMemPool(&pool, device) == cudaSuccess; device++) {
        cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &keep);
    }
    (void)cudaGetLastError();
    for (i = 0; i < row_count; i++) {
        char kind[32], weights = 0;
        int dim;
        double count;
        const int moves = strncmp(rows[i], "loop:", 5) == 0;
        if (sscanf(rows[i] + (moves ? 5 : 0), "%31[^:]:%d:%lf:%c", kind, &dim, &count, &weights) < 3) {
            printf("%s: not [loop:]KIND:DIM:COUNT[:w]\n", rows[i]);
            return 2;
        }
        fault |= moves ? loop_row(kind, dim, (size_t)count, weights == 'w', runs)
                       : row(kind, dim, (size_t)count, weights == 'w', runs, cpu_most, cards, &memory);
    }
    if (system("nvidia-smi --query-gpu=clocks.sm,clocks_throttle_reasons.active --format=csv,noheader") != 0) {
        printf("clocks unknown\n");
    }
    return fault;
}
