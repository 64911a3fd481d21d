/* test_contract.c: what calls do with arguments that are wrong: they say so before they read, work or report; meshes
   that are none, points that moved, more simplices than facets can be numbered; and clocks that are set. */
#if defined(__linux__)
#define _GNU_SOURCE
#endif
#include "pbw_check.h"
#include "pbw_live.h"
#include "pbw_query.h"
#include "inputs.h"
#include "test.h"

#include <limits.h>
#include <pthread.h>
#ifdef __linux__
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
#endif

enum { POINTS = 1000, QUERIES = 150 };

/* ---- arguments first */

static int stop(void *user, pbw_stage stage, double done)
{
    (void)stage;
    (void)done;
    ++*(long *)user;
    return 1;
}

static pbw_status nothing(void *arg, size_t from, size_t to)
{
    (void)arg;
    (void)from;
    (void)to;
    return PBW_OK;
}

/* Whether a call with a wrong argument says so, and its callback, which would cancel it, was not called. */
#define REFUSES(call) \
    do { \
        calls = 0; \
        CHECK_EQUAL(call, PBW_ERROR_ARGUMENT); \
        CHECK_EQUAL(calls, 0); \
    } while (0)

static void test_arguments(int dim)
{
    static double points[3 * POINTS], queries[3 * QUERIES];
    static pbw_index place[POINTS], at[QUERIES];
    const int dims[] = { 0, 1, 4, -1, INT_MIN, INT_MAX };
    pbw_options options, strided;
    pbw_lists stars, lists;
    pbw_finder *finder;
    pbw_report report;
    pbw_hash_sums sums;
    pbw_mesh mesh, wrong;
    long calls = 0;
    size_t i;
    if (!test_begin("wrong arguments come before work and progress: %dD", dim)) {
        return;
    }
    input_fill(INPUT_UNIFORM, dim, POINTS, 1, points);
    input_fill(INPUT_UNIFORM, dim, QUERIES, 2, queries);
    CHECK_EQUAL(pbw_triangulate(dim, points, NULL, POINTS, NULL, &mesh), PBW_OK);
    memset(&options, 0, sizeof options);
    memset(&stars, 0, sizeof stars);
    options.progress = stop;
    options.progress_user = &calls;
    strided = options;
    strided.stride = sizeof(double);
    stars.count = POINTS - 1;
    REFUSES(pbw_order(dim, points, POINTS, &options, NULL));
    REFUSES(pbw_order(dim, NULL, POINTS, &options, place));
    REFUSES(pbw_order(dim, points, POINTS, &strided, place));
    REFUSES(pbw_locate(&mesh, NULL, QUERIES, &options, at, NULL));
    REFUSES(pbw_locate(&mesh, queries, QUERIES, &options, NULL, NULL));
    REFUSES(pbw_locate(&mesh, queries, QUERIES, &strided, at, NULL));
    REFUSES(pbw_nearest(&mesh, &stars, queries, QUERIES, 1, &options, at, NULL));
    REFUSES(pbw_nearest(&mesh, NULL, queries, QUERIES, 1, &options, NULL, NULL));
    memset(&lists, 0xff, sizeof lists);
    REFUSES(pbw_within(&mesh, NULL, queries, QUERIES, -1, &options, &lists));
    CHECK(lists.count == 0 && lists.memory == NULL);
    REFUSES(pbw_within(&mesh, &stars, queries, QUERIES, 1, &options, &lists));
    REFUSES(pbw_coordinates(&mesh, queries, QUERIES, (pbw_scheme)9, &options, &lists));
    REFUSES(pbw_stars(&mesh, &options, NULL));
    REFUSES(pbw_for(&options, 1, 0, nothing, NULL));
    for (i = 0; i < sizeof dims / sizeof *dims; i++) {
        wrong = mesh;
        wrong.dim = dims[i];
        REFUSES(pbw_order(dims[i], points, POINTS, &options, place));
        REFUSES(pbw_triangulate(dims[i], points, NULL, POINTS, &options, &wrong));
        wrong = mesh;
        wrong.dim = dims[i];
        REFUSES(pbw_check(&wrong, &options, &report));
        REFUSES(pbw_hash_parts(&wrong, NULL, NULL, &options, &sums));
        REFUSES(pbw_locate(&wrong, queries, QUERIES, &options, at, NULL));
        REFUSES(pbw_nearest(&wrong, NULL, queries, QUERIES, 1, &options, at, NULL));
        REFUSES(pbw_stars(&wrong, &options, &lists));
        REFUSES(pbw_within(&wrong, NULL, queries, QUERIES, 1, &options, &lists));
        REFUSES(pbw_coordinates(&wrong, queries, QUERIES, PBW_SIBSON, &options, &lists));
        REFUSES(pbw_finder_create(&wrong, &options, &finder));
        CHECK_EQUAL(pbw_hash(&wrong, NULL), 0);
    }
    options.threads = -1;
    REFUSES(pbw_for(&options, 1, 1, nothing, NULL));
    REFUSES(pbw_check(&mesh, &options, &report));
    REFUSES(pbw_locate(&mesh, queries, QUERIES, &options, at, NULL));
    pbw_free(&mesh);
    test_end();
}

/* ---- hashes of what is no mesh */

static void test_hashes(void)
{
    const double points[8] = { 0, 0, 1, 0, 0, 1, 1, 0 };               /* the last is a duplicate of the second */
    pbw_index corners[6];
    pbw_hash_sums sums;
    pbw_mesh mesh, wrong;
    uint64_t right;
    size_t i;
    if (!test_begin("hashes of what is no mesh")) {
        return;
    }
    CHECK_EQUAL(pbw_hash_of(NULL), 0);
    CHECK_EQUAL(pbw_triangulate(2, points, NULL, 4, NULL, &mesh), PBW_OK);
    CHECK(mesh.simplex_count == 1 && mesh.duplicate_count == 1);
    memcpy(corners, mesh.simplices, 3 * sizeof *corners);
    wrong = mesh;
    wrong.simplices = corners;
    right = pbw_hash(&mesh, NULL);
    CHECK(right != 0 && pbw_hash(&wrong, NULL) == right);
    for (i = 0; i < 3; i++) {
        static const pbw_index ids[] = { 3, 4, 1000000000, PBW_NONE };       /* the duplicate; no points */
        size_t k;
        for (k = 0; k < sizeof ids / sizeof *ids; k++) {
            corners[i] = ids[k];
            CHECK_EQUAL(pbw_hash(&wrong, NULL), 0);
            CHECK_EQUAL(pbw_hash_parts(&wrong, NULL, NULL, NULL, &sums), PBW_ERROR_ARGUMENT);
        }
        corners[i] = mesh.simplices[i];
    }
    wrong.points = NULL;
    CHECK_EQUAL(pbw_hash(&wrong, NULL), 0);
    wrong = mesh;
    wrong.simplices = NULL;
    CHECK_EQUAL(pbw_hash(&wrong, NULL), 0);
    wrong = mesh;
    wrong.canonical = NULL;
    CHECK_EQUAL(pbw_hash(&wrong, NULL), 0);
    pbw_free(&mesh);
    test_end();
}

/* ---- borrowed points that moved: any answer, but an end */

#ifdef __linux__
static void limit_seconds(long seconds)              /* of processor time, however busy the machine is; 0: no limit */
{
    struct itimerval timer;
    memset(&timer, 0, sizeof timer);
    timer.it_value.tv_sec = seconds;
    setitimer(ITIMER_VIRTUAL, &timer, NULL);
}
#endif

static void test_moved(int dim)
{
    static double points[3 * POINTS], queries[3 * QUERIES];
    static pbw_index at[4 * QUERIES], facets[QUERIES];
    const size_t each = (size_t)dim;
    size_t i, k, ended = 0, kind;
    if (!test_begin("queries in a mesh with points that moved come to an end: %dD", dim)) {
        return;
    }
#ifdef __linux__
    limit_seconds(120);                              /* a walk without end ends the test */
#endif
    for (kind = 0; kind < 6; kind++) {
        pbw_options options;
        pbw_mesh mesh;
        pbw_lists lists;
        pbw_finder *finder;
        uint64_t state = kind;
        pbw_status status;
        memset(&options, 0, sizeof options);
        options.flags = PBW_BORROW;
        input_fill(INPUT_UNIFORM, dim, POINTS, 1 + kind, points);
        input_fill(INPUT_UNIFORM, dim, QUERIES, 2 + kind, queries);
        CHECK_EQUAL(pbw_triangulate(dim, points, NULL, POINTS, &options, &mesh), PBW_OK);
        for (i = 0; i < POINTS * each; i++) {        /* by less than an edge, by more, by all; mirrored; one place */
            const double by = kind == 0 ? 0.01 : kind == 1 ? 0.1 : kind == 2 ? 1 : 0;
            points[i] = kind == 3 ? -points[i] : kind == 4 ? 0.5 : points[i] + by * input_uniform(&state);
        }
        if (kind == 5) {                             /* exchanged */
            for (i = 0; i + 1 < POINTS; i += 2) {
                for (k = 0; k < each; k++) {
                    const double x = points[i * each + k];
                    points[i * each + k] = points[(POINTS - 1 - i) * each + k];
                    points[(POINTS - 1 - i) * each + k] = x;
                }
            }
        }
        options.flags = 0;
        status = pbw_locate(&mesh, queries, QUERIES, &options, at, facets);
        CHECK(status == PBW_OK || status == PBW_ERROR_ARGUMENT);
        ended += status != PBW_OK;
        for (i = 0; i < QUERIES; i++) {
            const pbw_index t = pbw_locate_one(&mesh, queries + i * each, (pbw_index)i, facets);
            CHECK(t == PBW_NONE || t < mesh.simplex_count);
            CHECK(*facets == PBW_NONE || (*facets < (each + 1) * mesh.simplex_count
                                          && mesh.neighbors[*facets] == PBW_NONE));
        }
        CHECK_EQUAL(pbw_finder_create(&mesh, &options, &finder), PBW_OK);
        for (i = 0; i < QUERIES; i++) {
            (void)pbw_finder_locate(finder, queries + i * each, NULL);
        }
        pbw_finder_free(finder);
        for (i = 0; i < 3; i++) {
            status = pbw_coordinates(&mesh, queries, QUERIES, (pbw_scheme)i, &options, &lists);
            CHECK(status == PBW_OK || (status == PBW_ERROR_ARGUMENT && lists.count == 0));
            pbw_lists_free(&lists);
        }
        CHECK_EQUAL(pbw_nearest(&mesh, NULL, queries, QUERIES, 4, &options, at, NULL), PBW_OK);
        CHECK_EQUAL(pbw_within(&mesh, NULL, queries, QUERIES, 0.05, &options, &lists), PBW_OK);
        pbw_lists_free(&lists);
        CHECK_EQUAL(pbw_stars(&mesh, &options, &lists), PBW_OK);
        CHECK_EQUAL(pbw_nearest(&mesh, &lists, queries, QUERIES, 4, &options, at, NULL), PBW_OK);
        pbw_lists_free(&lists);
        pbw_free(&mesh);
    }
#ifdef __linux__
    limit_seconds(0);
#endif
    test_say("%lu of 6 batches were ended", (unsigned long)ended);
    CHECK(ended > 0);
    test_end();
}

/* ---- numbers of points that are too large: nothing is read */

static void test_counts(void)
{
    const double square[8] = { 0, 0, 1, 0, 0, 1, 1, 1 };
    const size_t counts[] = { (size_t)-1, (size_t)-1 / 256, (size_t)1 << 31, 100000000 };
    pbw_index ids[4] = { 0, 1, 2, 3 };
    pbw_options options;
    pbw_live *live;
    pbw_mesh none, view;
    size_t i;
    if (!test_begin("numbers of points that are too large")) {
        return;
    }
    memset(&none, 0, sizeof none);
    memset(&options, 0, sizeof options);
    none.dim = 2;
    options.memory_limit = 1000000;
    CHECK_EQUAL(pbw_live_create(&none, &options, &live), PBW_DEGENERATE);
    CHECK_EQUAL(pbw_live_insert(live, square, NULL, 4, NULL), PBW_OK);
    for (i = 0; i < sizeof counts / sizeof *counts; i++) {
        const pbw_status status = pbw_live_insert(live, square, square, counts[i], NULL);
        CHECK(status == (i < 3 ? PBW_ERROR_TOO_LARGE : PBW_ERROR_MEMORY));
        CHECK_EQUAL(pbw_live_remove(live, ids, counts[i]), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_live_move(live, NULL, square, counts[i]), PBW_ERROR_ARGUMENT);
    }
    CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
    CHECK_EQUAL(pbw_live_view(live, &view), PBW_OK);
    CHECK(view.point_count == 4 && view.simplex_count == 2);
    pbw_free(&view);
    pbw_live_free(live);
    test_end();
}

/* ---- more simplices than facets can be numbered: those of a small mesh, behind others, only address space */

static void test_many(int dim)
{
#if defined(__linux__) && defined(__LP64__)
    const size_t corners = (size_t)dim + 1, before = PBW_NONE / corners + 1, small = 4096;
    const double queries[6] = { 0.5, 0.5, 0.5, 9, 9, 9 };
    static double points[3 * 100];
    pbw_index *array[2], at[2], facets[2];
    pbw_mesh mesh, large;
    size_t bytes, i, k;
    if (!test_begin("more simplices than facets can be numbered: %dD", dim)) {
        return;
    }
    input_fill(INPUT_UNIFORM, dim, 100, 1, points);
    CHECK_EQUAL(pbw_triangulate(dim, points, NULL, 100, NULL, &mesh), PBW_OK);
    CHECK(mesh.simplex_count < small);
    bytes = (before + small) * corners * sizeof(pbw_index);
    for (k = 0; k < 2; k++) {
        void *map = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (map == MAP_FAILED) {
            test_skip("no address space");
            return;
        }
        array[k] = (pbw_index *)map;
    }
    for (i = 0; i < mesh.simplex_count * corners; i++) {
        const pbw_index next = mesh.neighbors[i];
        array[0][before * corners + i] = mesh.simplices[i];
        array[1][before * corners + i] = next == PBW_NONE ? PBW_NONE : next + (pbw_index)before;
    }
    large = mesh;
    large.simplices = array[0];
    large.neighbors = array[1];
    large.simplex_count = before + mesh.simplex_count;
    for (i = 0; i < 100; i++) {
        ((pbw_index *)(uintptr_t)large.incident)[i] += (pbw_index)before;
    }
    CHECK_EQUAL(pbw_locate(&large, queries, 1, NULL, at, facets), PBW_OK);
    CHECK_EQUAL(pbw_locate(&large, queries + 3, 1, NULL, at + 1, facets + 1), PBW_OK);
    CHECK_EQUAL(at[0], before + pbw_locate_one(&mesh, queries, 0, NULL));
    CHECK(at[1] == PBW_NONE && facets[0] == PBW_NONE && facets[1] == PBW_NONE);
    CHECK_EQUAL(pbw_locate_one(&large, queries + 3, (pbw_index)before, facets), PBW_NONE);
    CHECK_EQUAL(facets[0], PBW_NONE);
    munmap(array[0], bytes);
    munmap(array[1], bytes);
    pbw_free(&mesh);
    test_end();
#else
    (void)dim;
#endif
}

/* ---- the wall clock may be set: it is not read */

#if defined(__linux__) && defined(__GLIBC__) && defined(__USE_GNU) && !defined(TEST_SANITIZED)
#if __GLIBC_PREREQ(2, 30)
#define CLOCKS
static long wall_reads, waits, late;        /* late: waits that would end by another clock */

int gettimeofday(struct timeval *restrict now, void *restrict zone)         /* goes back an hour each time */
{
    (void)zone;
    now->tv_sec = 1000000000 - 3600 * ++wall_reads;
    now->tv_usec = 0;
    return 0;
}

int pthread_cond_timedwait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex,
                           const struct timespec *restrict until)
{
    struct timespec now, soon;
    double wait;
    clock_gettime(CLOCK_MONOTONIC, &now);
    wait = (double)(until->tv_sec - now.tv_sec) + 1e-9 * (double)(until->tv_nsec - now.tv_nsec);
    waits++;
    late += !(wait > -30 && wait <= 0.0501);         /* a busy machine may come late to this line */
    soon = now;
    soon.tv_sec += 1;
    return pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, late ? &soon : until);
}

typedef struct two { pthread_t caller; int others; } two;

/* The caller's ranges wait until another thread has begun one; those take 120 ms each. */
static pbw_status slow(void *arg, size_t from, size_t to)
{
    two *t = (two *)arg;
    (void)from;
    (void)to;
    if (!pthread_equal(pthread_self(), t->caller)) {
        __atomic_store_n(&t->others, 1, __ATOMIC_RELAXED);
        usleep(120000);
    } else {
        int tries;
        for (tries = 0; tries < 20000 && !__atomic_load_n(&t->others, __ATOMIC_RELAXED); tries++) {
            usleep(500);
        }
    }
    return PBW_OK;
}

static int count_calls(void *user, pbw_stage stage, double done)
{
    (void)stage;
    (void)done;
    ++*(long *)user;
    return 0;
}
#endif
#endif

static void test_clocks(void)
{
#ifdef CLOCKS
    static double points[3 * POINTS];
    two t = { pthread_self(), 0 };
    pbw_options options;
    pbw_mesh mesh;
    long calls = 0;
    if (!test_begin("a clock that is set back changes nothing")) {
        return;
    }
    memset(&options, 0, sizeof options);
    options.threads = 2;
    options.progress = count_calls;
    options.progress_user = &calls;
    input_fill(INPUT_UNIFORM, 3, POINTS, 1, points);
    CHECK_EQUAL(pbw_triangulate(3, points, NULL, POINTS, &options, &mesh), PBW_OK);
    CHECK(mesh.statistics.order_seconds >= 0 && mesh.statistics.build_seconds >= 0
          && mesh.statistics.output_seconds >= 0);
    pbw_free(&mesh);
    CHECK_EQUAL(pbw_for(&options, 2, 1, slow, &t), PBW_OK);
    test_say("%ld waits", waits);
    CHECK(waits > 0 && late == 0 && wall_reads == 0 && calls > 0);
    test_end();
#endif
}

int main(int argc, char **argv)
{
    int dim;
    test_start(argc, argv, 0);
    for (dim = 2; dim <= 3; dim++) {
        test_arguments(dim);
        test_moved(dim);
        test_many(dim);
    }
    test_hashes();
    test_counts();
    test_clocks();
    return test_finish();
}
