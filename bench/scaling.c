/* scaling.c: how calls on a finished mesh scale with threads: make bench-scaling [ARGS="[solids] COUNT THREADS..."]

   Uniform points (default 1,000,000; threads 1, 2, 4, ... up to the processors).  A row is one call, seconds of the
   clock, the best of three, and for more threads how many times as fast as on one.  Live batches are of a tenth of
   the points, or of a hundredth, commit included; moves are by a tenth of the mean distance, or anywhere.  The last
   rows mesh a ball in steps that suit the number of points, once, and improve that mesh; with `solids` there are only
   these. */
#define PBW_IMPLEMENTATION
#define PBW_CHECK_IMPLEMENTATION
#include "pbw_check.h"
#define PBW_QUERY_IMPLEMENTATION
#include "pbw_query.h"
#define PBW_LIVE_IMPLEMENTATION
#include "pbw_live.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#define PBW_SURFACE_IMPLEMENTATION
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_MESH3_IMPLEMENTATION
#include "pbw_mesh3.h"
#include "../tests/inputs.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { MOST = 16, ROWS = 40, RUNS = 3 };

typedef struct bench {
    int dim, columns, column, threads[MOST], rows, only_solids;
    double seconds[ROWS][MOST];
    const char *names[ROWS];
    size_t count, batch;
    double *points, *others, *moved;
    pbw_index *ids;
    pbw_options options;
} bench;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void good(pbw_status status)
{
    if (status != PBW_OK) {
        printf("%s\n", pbw_status_string(status));
        exit(1);
    }
}

/* Keeps the least of a row's times; rows come in one order in every run. */
static void row(bench *b, const char *name, double seconds)
{
    double *best = &b->seconds[b->rows][b->column];
    if (*best == 0 || seconds < *best) {
        *best = seconds;
    }
    b->names[b->rows++] = name;
}

static void *take(size_t count, size_t size)
{
    void *memory = malloc(count * size);
    if (memory == NULL) {
        good(PBW_ERROR_MEMORY);
    }
    return memory;
}

static void queries(bench *b, const pbw_mesh *mesh)
{
    pbw_index *found = (pbw_index *)take(8 * b->count, sizeof *found);
    pbw_report report;
    pbw_lists stars, lists;
    pbw_finder *finder;
    double start = now();
    good(pbw_check(mesh, &b->options, &report));
    row(b, "check", now() - start);
    start = now();
    good(pbw_stars(mesh, &b->options, &stars));
    row(b, "stars", now() - start);
    start = now();
    good(pbw_locate(mesh, b->others, b->count, &b->options, found, NULL));
    row(b, "locate", now() - start);
    start = now();
    good(pbw_nearest(mesh, &stars, b->others, b->count, 1, &b->options, found, NULL));
    row(b, "nearest", now() - start);
    start = now();
    good(pbw_nearest(mesh, &stars, b->others, b->count, 8, &b->options, found, NULL));
    row(b, "8 nearest", now() - start);
    start = now();
    good(pbw_coordinates(mesh, b->others, b->batch, PBW_SIBSON, &b->options, &lists));
    row(b, "Sibson coordinates, a tenth", now() - start);
    pbw_lists_free(&lists);
    pbw_lists_free(&stars);
    start = now();
    good(pbw_finder_create(mesh, &b->options, &finder));
    row(b, "finder: create", now() - start);
    pbw_finder_free(finder);
    free(found);
}

static void cells(bench *b, const pbw_mesh *mesh)
{
    const double box[6] = { 0, 0, b->dim == 3 ? 0.0 : 1.0, 1, 1, 1 };
    static const char *const names[] = { "cells: volumes", "cells: and facets", "cells: and shapes" };
    static const unsigned what[] = { 0, PBW_CELLS_FACETS, PBW_CELLS_SHAPES };
    int k;
    for (k = 0; k < 3; k++) {
        pbw_domain domain;
        pbw_cells made;
        double start = now();
        memset(&domain, 0, sizeof domain);
        domain.box = box;
        good(pbw_cells_of(mesh, &domain, what[k], &b->options, &made));
        row(b, names[k], now() - start);
        pbw_cells_free(&made);
    }
}

/* A tenth is replaced, for the second time on, as batches after the first know more; then one comes to a corner. */
static void come_and_go(bench *b, pbw_live *live)
{
    const size_t width = (size_t)b->dim;
    double *corner = (double *)take(b->batch, width * sizeof *corner), start;
    size_t i;
    int turn;
    for (turn = 0; turn < 2; turn++) {
        start = now();
        good(pbw_live_remove(live, b->ids, b->batch));
        good(pbw_live_insert(live, b->others + ((size_t)turn + 1) * width * b->batch, NULL, b->batch, b->ids));
        good(pbw_live_commit(live, NULL));
    }
    row(b, "live: replace a tenth", now() - start);
    for (i = 0; i < width * b->batch; i++) {
        corner[i] = 0.3 + 0.01 * b->others[i];
    }
    good(pbw_live_remove(live, b->ids, b->batch));
    good(pbw_live_commit(live, NULL));
    start = now();
    good(pbw_live_insert(live, corner, NULL, b->batch, b->ids));
    good(pbw_live_commit(live, NULL));
    row(b, "live: insert a tenth in a corner", now() - start);
    free(corner);
}

static void lives(bench *b, const pbw_mesh *mesh)
{
    pbw_live *live;
    pbw_mesh view;
    double start = now();
    good(pbw_live_create(mesh, &b->options, &live));
    row(b, "live: create", now() - start);
    start = now();
    good(pbw_live_view(live, &view));
    row(b, "live: view", now() - start);
    pbw_free(&view);
    start = now();
    good(pbw_live_remove(live, b->ids, b->batch));
    good(pbw_live_commit(live, NULL));
    row(b, "live: remove a tenth", now() - start);
    start = now();
    good(pbw_live_insert(live, b->points, NULL, b->batch, b->ids));
    good(pbw_live_commit(live, NULL));
    row(b, "live: insert a tenth", now() - start);
    start = now();
    good(pbw_live_move(live, b->ids, b->moved, b->batch));
    good(pbw_live_commit(live, NULL));
    row(b, "live: move a tenth", now() - start);
    start = now();
    good(pbw_live_move(live, b->ids, b->points, b->batch / 10));
    good(pbw_live_commit(live, NULL));
    row(b, "live: move a hundredth", now() - start);
    start = now();
    good(pbw_live_move(live, b->ids, b->others, b->batch));
    good(pbw_live_commit(live, NULL));
    row(b, "live: move a tenth, far", now() - start);
    come_and_go(b, live);
    pbw_live_free(live);
}

static void all(bench *b)
{
    pbw_mesh mesh;
    double start = now();
    size_t i;
    good(pbw_triangulate(b->dim, b->points, NULL, b->count, &b->options, &mesh));
    row(b, "build", now() - start);
    for (i = 0; i < b->batch; i++) {
        b->ids[i] = (pbw_index)i;
    }
    queries(b, &mesh);
    cells(b, &mesh);
    lives(b, &mesh);
    pbw_free(&mesh);
}

static double ball(void *user, const double p[3])
{
    (void)user;
    return p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - 1;
}

static void solids(bench *b)
{
    pbw_solid_input input;
    pbw_solid_options how;
    pbw_tets raw, better;
    double start = now();
    int k;
    memset(&input, 0, sizeof input);
    memset(&how, 0, sizeof how);
    input.value = ball;
    for (k = 0; k < 3; k++) {
        input.box[k] = -1.25;
        input.box[3 + k] = 1.25;
    }
    how.size = 3.3 / pow((double)b->count, 1.0 / 3);
    how.improve.target = -1;
    good(pbw_solid(&input, &how, &b->options, &raw, NULL, NULL));
    row(b, "solid: a ball, as it is", now() - start);
    start = now();
    good(pbw_improve(&raw, NULL, &b->options, &better, NULL));
    row(b, "solid: improved to 30 degrees", now() - start);
    pbw_tets_free(&better);
    pbw_tets_free(&raw);
}

static void print(const bench *b)
{
    int i, k;
    printf("%dD, %zu points%*s", b->dim, b->count, 12, "");
    for (k = 0; k < b->columns; k++) {
        printf("%9d%s", b->threads[k], k > 0 ? "        " : "");
    }
    printf(" threads\n");
    for (i = 0; i < b->rows; i++) {
        printf("%-32s", b->names[i]);
        for (k = 0; k < b->columns; k++) {
            printf("%9.4f", b->seconds[i][k]);
            if (k > 0) {
                printf(" (%4.1fx)", b->seconds[i][0] / b->seconds[i][k]);
            }
        }
        printf("\n");
    }
    fflush(stdout);
}

static void run(bench *b)
{
    const double step = 0.1 / pow((double)b->count, 1.0 / b->dim);
    size_t i;
    int run;
    memset(b->seconds, 0, sizeof b->seconds);
    b->points = (double *)take(b->count, (size_t)b->dim * sizeof(double));
    b->others = (double *)take(b->count, (size_t)b->dim * sizeof(double));
    b->moved = (double *)take(b->batch, (size_t)b->dim * sizeof(double));
    b->ids = (pbw_index *)take(b->count, sizeof *b->ids);
    input_fill(INPUT_UNIFORM, b->dim, b->count, 1, b->points);
    input_fill(INPUT_UNIFORM, b->dim, b->count, 2, b->others);
    for (i = 0; i < b->batch * (size_t)b->dim; i++) {
        b->moved[i] = b->points[i] + step * (2 * b->others[i] - 1);
    }
    for (run = 0; run < RUNS; run++) {
        for (b->column = 0; b->column < b->columns; b->column++) {
            b->options.threads = b->threads[b->column];
            b->rows = 0;
            if (!b->only_solids) {
                all(b);
            }
            if (b->only_solids || (b->dim == 3 && run == 0)) {
                solids(b);
            }
        }
    }
    b->rows += !b->only_solids && b->dim == 3 ? 2 : 0;
    print(b);
    free(b->points);
    free(b->others);
    free(b->moved);
    free(b->ids);
}

int main(int argc, char **argv)
{
    bench b;
    int k;
    memset(&b, 0, sizeof b);
    b.only_solids = argc > 1 && strcmp(argv[1], "solids") == 0;
    argv += b.only_solids;
    argc -= b.only_solids;
    b.count = argc > 1 ? (size_t)atol(argv[1]) : 1000000;
    b.batch = b.count / 10;
    for (k = 2; k < argc && b.columns < MOST; k++) {
        b.threads[b.columns++] = atoi(argv[k]);
    }
    for (k = 1; argc <= 2 && (k == 1 || k <= PBW__CORES()) && b.columns < MOST; k *= 2) {
        b.threads[b.columns++] = k;
    }
    for (b.dim = b.only_solids ? 3 : 2; b.dim <= 3; b.dim++) {
        run(&b);
    }
    return 0;
}
