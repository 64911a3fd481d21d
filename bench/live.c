/* live.c: every number that is demanded of live triangulations, with its goal: make bench-live-goals [ARGS="COUNT"]

   Uniform points (default 1,000,000), times of the clock, the best of three; a batch is a tenth of them.  B is our own
   build of all points on one thread, in the same run.  A row has the value, the goal, what would be better still, and
   whether they are reached.  Rates beside CGAL's are those of bench/live.cpp. */
#define PBW_IMPLEMENTATION
#define PBW_LIVE_IMPLEMENTATION
#include "pbw_live.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#include "../examples/swarm.h"
#include "../tests/inputs.h"

#include <stdio.h>
#include <time.h>

enum { CREATE, VIEW, REMOVE, INSERT, MOVE, VERIFY, FEW, STEPS, RUNS = 3, FRAMES = 60 };
static const char *const names[] = { "create", "view", "remove", "insert", "move", "verify", "move 1 %" };

typedef struct bench {
    int dim;
    size_t count, batch;
    double *points, *moved, build[2], seconds[2][STEPS];     /* of one thread, of four */
    pbw_index *ids;
    pbw_mesh mesh;
} bench;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void good(int works)
{
    if (!works) {
        printf("a call has failed\n");
        exit(1);
    }
}

static void *take(size_t size)
{
    void *memory = malloc(size);
    good(memory != NULL);
    return memory;
}

static void keep(double *best, double start)
{
    const double seconds = now() - start;
    if (*best == 0 || seconds < *best) {
        *best = seconds;
    }
}

/* fewer: whether small values are good. */
static void row(const char *name, double value, const char *unit, double goal, double aim, int fewer)
{
    const int met = fewer ? value <= goal : value >= goal, more = fewer ? value <= aim : value >= aim;
    printf("%-46s %9.2f %-9s goal %8.2f  aim %8.2f   %s\n", name, value, unit, goal, aim,
           goal == 0 ? "" : more ? "aim reached" : met ? "reached" : "MISSED");
    fflush(stdout);
}

/* New places for the first points, at most step away along each axis. */
static void shift(const bench *b, size_t count, double step, uint64_t seed)
{
    uint64_t state = seed;
    size_t i;
    for (i = 0; i < count * (size_t)b->dim; i++) {
        b->moved[i] = b->points[i] + step * (2 * input_uniform(&state) - 1);
    }
}

static void measure(bench *b, const pbw_options *options, double *seconds)
{
    const double edge = 1.0 / pow((double)b->count, 1.0 / b->dim);
    pbw_live *live;
    pbw_mesh view;
    double start = now();
    good(pbw_live_create(&b->mesh, options, &live) == PBW_OK);
    keep(seconds + CREATE, start);
    shift(b, b->count, 1e-10 * edge, 1);
    start = now();
    good(pbw_live_move(live, NULL, b->moved, b->count) == PBW_OK && pbw_live_commit(live, NULL) == PBW_OK);
    keep(seconds + VERIFY, start);
    shift(b, b->count / 100, 0.1 * edge, 2);
    start = now();
    good(pbw_live_move(live, b->ids, b->moved, b->count / 100) == PBW_OK && pbw_live_commit(live, NULL) == PBW_OK);
    keep(seconds + FEW, start);
    start = now();
    good(pbw_live_remove(live, b->ids, b->batch) == PBW_OK && pbw_live_commit(live, NULL) == PBW_OK);
    keep(seconds + REMOVE, start);
    start = now();
    good(pbw_live_insert(live, b->points, NULL, b->batch, b->ids) == PBW_OK
         && pbw_live_commit(live, NULL) == PBW_OK);
    keep(seconds + INSERT, start);
    shift(b, b->batch, 0.1 * edge, 3);
    start = now();
    good(pbw_live_move(live, b->ids, b->moved, b->batch) == PBW_OK && pbw_live_commit(live, NULL) == PBW_OK);
    keep(seconds + MOVE, start);
    start = now();
    good(pbw_live_view(live, &view) == PBW_OK);
    keep(seconds + VIEW, start);
    pbw_free(&view);
    pbw_live_free(live);
}

static void report(const bench *b)
{
    static const double goal[2][5] = { { 1500, 0, 800, 0.15, 0.06 }, { 250, 300, 130, 0.25, 0.12 } };
    static const double aim[2][3] = { { 3000, 0, 1500 }, { 500, 600, 300 } };
    const double *t = b->seconds[0], build = b->build[0], changes = (double)b->batch / 1000;
    const int space = b->dim == 3;
    char name[80];
    int k;
    printf("%dD, %lu points, B = %.3f us a point\n", b->dim, (unsigned long)b->count, 1e6 * build / (double)b->count);
    row("  create: a build of its own", t[CREATE] / build, "B", 1.2, 1.1, 1);
    row("  view, after changes", t[VIEW] / build, "B", 0.25, 0.15, 1);
    row("  verify: all move by 1e-10 of an edge", t[VERIFY] / build, "B", goal[space][3], goal[space][4], 1);
    row("  remove a tenth", changes / t[REMOVE], "k/s", goal[space][0], aim[space][0], 0);
    row("  insert a tenth", changes / t[INSERT], "k/s", goal[space][1], aim[space][1], 0);
    row("  move a tenth by 0.1 of an edge", changes / t[MOVE], "k/s", goal[space][2], aim[space][2], 0);
    row("  move 1 % by 0.1 of an edge, beside a rebuild", build / t[FEW], "times", 8, 15, 0);
    for (k = 0; k < VERIFY; k++) {
        sprintf(name, "  %s, 4 threads", names[k]);
        row(name, t[k] / b->seconds[1][k], "times", 3, 4, 0);
    }
}

/* A swarm: points that drift, on one thread; and that jump anywhere, on four, with arrays and cells. */
static void swarms(void)
{
    double drift[FRAMES], jump = 0, start;
    swarm s;
    int i, k;
    good(swarm_start(&s, 100000, 1) == PBW_OK);
    for (i = 0; i < FRAMES; i++) {
        start = now();
        good(swarm_frame(&s) == PBW_OK);
        drift[i] = now() - start;
        for (k = i; k > 0 && drift[k] < drift[k - 1]; k--) {
            const double swap = drift[k];
            drift[k] = drift[k - 1];
            drift[k - 1] = swap;
        }
    }
    good(swarm_is_exact(&s));
    swarm_free(&s);
    row("2D, 100,000 drift, with cells: median, 1 thread", 1 / drift[FRAMES / 2], "frames/s", 60, 120, 0);
    good(swarm_start(&s, 100000, 4) == PBW_OK);
    for (i = 0; i < 5; i++) {
        input_fill(INPUT_UNIFORM, 2, s.count, (uint64_t)i + 2, s.points);
        start = now();
        good(swarm_follow(&s) == PBW_OK);
        keep(&jump, start);
    }
    swarm_free(&s);
    row("2D, 100,000 jump, with cells: 4 threads", 1 / jump, "frames/s", 60, 120, 0);
}

int main(int argc, char **argv)
{
    bench b;
    pbw_options options;
    size_t i;
    int run, four;
    memset(&b, 0, sizeof b);
    memset(&options, 0, sizeof options);
    b.count = argc > 1 ? (size_t)atol(argv[1]) : 1000000;
    b.batch = b.count / 10;
    b.points = (double *)take(b.count * 3 * sizeof(double));
    b.moved = (double *)take(b.count * 3 * sizeof(double));
    b.ids = (pbw_index *)take(b.count * sizeof *b.ids);
    for (b.dim = 2; b.dim <= 3; b.dim++) {
        input_fill(INPUT_UNIFORM, b.dim, b.count, 1, b.points);
        memset(b.build, 0, sizeof b.build);
        memset(b.seconds, 0, sizeof b.seconds);
        for (run = 0; run < 2 * RUNS; run++) {
            double start = now();
            four = run % 2;
            options.threads = four ? 4 : 1;
            good(pbw_triangulate(b.dim, b.points, NULL, b.count, &options, &b.mesh) == PBW_OK);
            keep(b.build + four, start);
            for (i = 0; i < b.batch; i++) {
                b.ids[i] = (pbw_index)i;
            }
            measure(&b, &options, b.seconds[four]);
            pbw_free(&b.mesh);
        }
        report(&b);
    }
    swarms();
    free(b.points);
    free(b.moved);
    free(b.ids);
    return 0;
}
