/* test_threads.c: the same bytes from any number of threads, whoever runs them and however they are held up; failures
   in the middle of the work; more simplices than can be numbered. */
#if defined(__linux__) || defined(__APPLE__)
#define _GNU_SOURCE                                  /* nanosleep */
#endif
#include <pthread.h>
#include <stddef.h>
#include <time.h>
#ifndef COUNT
#define COUNT 2000                                   /* points */
#endif

/* Hooks of pbw.h for this test: threads wait at random, and can be refused. */
static void pause_a_while(long *calls);
static int may_start_thread(void);
static long threads_allowed = -1;                    /* that may still be started; -1 = any number */
#ifdef PBW_WIDE
static size_t simplex_limit = 0xfffffffeu;           /* as without this test */
#else
static size_t simplex_limit = (size_t)1 << 30;
#endif
#define PBW__TEST_PAUSE() do { static long calls; pause_a_while(&calls); } while (0)
#define PBW__TEST_MAY_START() may_start_thread()
#define PBW__TEST_SMALL_SHARES
#define PBW__TEST_SIMPLEX_LIMIT simplex_limit
#ifdef PBW_WIDE
#define PBW_LIVE_IMPLEMENTATION
#endif
#define PBW_IMPLEMENTATION
#define PBW_CHECK_IMPLEMENTATION
#include "pbw_check.h"
#include "pbw_live.h"
#include "meshes.h"
#include "meter.h"
#include "test.h"
#include "watch.h"

#include <sched.h>
#if defined(PBW_WIDE) && defined(__linux__) && defined(__LP64__)
#define WIDE_SLOTS
#include <sys/mman.h>
#endif

/* Holds a thread up at random, by the number of calls at this place.  Where threads seldom pass (blocks of the store,
   40,000 of 17 million calls), each call may; where they often do (zones), a quarter of those after 100,000: enough to
   find faults of such places, and the system calls would take most of the test's time. */
static void pause_a_while(long *calls)
{
    const long call = __atomic_fetch_add(calls, 1, __ATOMIC_RELAXED);
    const int random = (int)((uint64_t)call * UINT64_C(0x9e3779b97f4a7c15) >> 56);
    int times = call < 100000 || (random & 24) == 0 ? random & 7 : 0;
    while (times-- > 0) {
        sched_yield();
    }
}

static int may_start_thread(void)
{
    if (threads_allowed > 0) {
        threads_allowed--;
        return 1;
    }
    return threads_allowed != 0;
}

typedef struct points { int dim; size_t count; double *x, *w; } points;

static points points_make(int kind, int dim, size_t count, int weights)
{
    points p;
    p.dim = dim;
    p.count = count;
    p.x = (double *)malloc(count * (size_t)dim * sizeof(double));
    p.w = weights != INPUT_WEIGHTS_ZERO ? (double *)malloc(count * sizeof(double)) : NULL;
    if (p.x == NULL || (weights != INPUT_WEIGHTS_ZERO && p.w == NULL)) {
        abort();
    }
    input_fill(kind, dim, count, test_seed, p.x);
    if (p.w != NULL) {
        input_fill_weights(weights, dim, count, test_seed, p.x, p.w);
    }
    return p;
}

static void points_free(points *p)
{
    free(p->x);
    free(p->w);
}

/* Builds with the options, on an allocator that counts, and compares with the right mesh. */
static void compare(const points *p, pbw_options options, const pbw_mesh *right)
{
    meter m;
    pbw_mesh mesh;
    meter_start(&m, 0, 0);
    options.resize = meter_resize;
    options.resize_user = &m;
    CHECK_EQUAL(pbw_triangulate(p->dim, p->x, p->w, p->count, &options, &mesh), PBW_OK);
    CHECK(meshes_equal(&mesh, right));
    CHECK(pbw_hash(&mesh, NULL) == pbw_hash(right, NULL));
    pbw_free(&mesh);
    CHECK(m.blocks == 0 && m.bytes == 0 && m.faults == 0);
}

static pbw_options with_threads(int threads)
{
    pbw_options options;
    memset(&options, 0, sizeof options);
    options.threads = threads;
    return options;
}

/* Job systems of a caller: backwards on one thread, and a thread for each task. */
typedef struct job { void (*task)(void *, int); void *arg; int i; } job;

static void run_backwards(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    ++*(long *)user;
    while (tasks-- > 0) {
        task(arg, tasks);
    }
}

static void *run_job(void *arg)
{
    const job *j = (const job *)arg;
    j->task(j->arg, j->i);
    return NULL;
}

static void run_on_threads(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    static const int most = 64;
    pthread_t thread[64];
    job jobs[64];
    int i, first;
    ++*(long *)user;
    for (first = 0; first < tasks; first += most) {
        int count = tasks - first < most ? tasks - first : most;
        for (i = 0; i < count; i++) {
            jobs[i].task = task;
            jobs[i].arg = arg;
            jobs[i].i = first + i;
            if (pthread_create(&thread[i], NULL, run_job, &jobs[i]) != 0) {
                abort();
            }
        }
        for (i = 0; i < count; i++) {
            pthread_join(thread[i], NULL);
        }
    }
}

static void test_same_bytes(size_t count)
{
    static const int threads[] = { 2, 3, 4, 7, 8, 16, 64, 256 };
    static const int weights[] = { INPUT_WEIGHTS_ZERO, INPUT_WEIGHTS_HIDING, INPUT_WEIGHTS_LEVELS };
    int dim, kind;
    size_t w, t;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            for (w = 0; w < sizeof weights / sizeof weights[0]; w++) {
                size_t n = kind == INPUT_MOMENT ? 300 : w == 0 ? count : count / 2;
                points p;
                pbw_mesh right;
                if (!test_begin("same bytes: %dD %s, weights %d", dim, input_name(kind), weights[w])) {
                    continue;
                }
                p = points_make(kind, dim, n, weights[w]);
                memcpy(p.x + (n - 1) * (size_t)dim, p.x, (size_t)dim * sizeof(double));     /* a duplicate */
                pbw_options one = with_threads(1);
                CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, n, &one, &right), PBW_OK);
                CHECK(meshes_fault(&right) == NULL);
                for (t = 0; t < sizeof threads / sizeof threads[0]; t++) {
                    if (threads[t] <= 16 || (size_t)kind % 3 == w) {     /* starting many takes longest of all */
                        compare(&p, with_threads(threads[t]), &right);
                    }
                }
                pbw_free(&right);
                points_free(&p);
                test_end();
            }
        }
    }
}

static void test_job_systems(size_t count)
{
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("job systems: %dD", dim)) {
            points p = points_make(INPUT_GAUSS, dim, count, INPUT_WEIGHTS_SMALL);
            pbw_options options = with_threads(1);
            pbw_mesh right;
            long calls = 0;
            CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, p.count, &options, &right), PBW_OK);
            options.threads = 5;
            options.run = run_backwards;
            options.run_user = &calls;
            compare(&p, options, &right);
            options.run = run_on_threads;
            compare(&p, options, &right);
            CHECK(calls > 10);                       /* it was asked to */
            pbw_free(&right);
            points_free(&p);
            test_end();
        }
    }
}

/* A job system that has the tasks run by options that share threads: so does another copy of pbw.h. */
static void run_by_shared(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    const pbw_options *shared = (const pbw_options *)user;
    shared->run(shared->run_user, tasks, task, arg);
}

/* Calls share threads that were started before, even if no memory or no thread could be had for them.  None are
   started for calls that the caller's job system runs, or that will be refused. */
static void test_shared_threads(size_t count)
{
    int dim, lack;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("shared threads: %dD", dim)) {
            points p = points_make(INPUT_GAUSS, dim, count, INPUT_WEIGHTS_SMALL);
            pbw_options one = with_threads(1), five = with_threads(5), inner, again;
            pbw_mesh right, mesh;
            meter m;
            long calls = 0;
            CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, count, &one, &right), PBW_OK);
            five.resize = meter_resize;
            five.resize_user = &m;
            five.memory_limit = (size_t)1 << 30;
            for (lack = 0; lack < 4; lack++) {       /* of nothing, of memory, of all threads, of two of them */
                pbw_threads *threads, *others;
                meter_start(&m, lack == 1, 0);
                threads_allowed = lack == 2 ? 0 : lack == 3 ? 2 : -1;
                threads = pbw_threads_start(&five, count, &inner);
                CHECK((threads != NULL) == (lack != 1));
                CHECK(inner.memory_limit > 0 && (inner.memory_limit < five.memory_limit) == (lack != 1));
                threads_allowed = lack == 0 ? 0 : -1;
                compare(&p, inner, &right);
                if (inner.run != NULL) {
                    again = with_threads(5);
                    again.run = run_by_shared;
                    again.run_user = &inner;
                    compare(&p, again, &right);
                }
                again = inner;                       /* which may be the same options */
                others = pbw_threads_start(&again, count, &again);
                CHECK((others == NULL && again.run == inner.run) == (lack != 1));
                CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, count, &again, &mesh), PBW_OK);
                CHECK(meshes_equal(&mesh, &right) && mesh.statistics.threads == (lack == 2 ? 1 : lack == 3 ? 3 : 5));
                pbw_free(&mesh);
                pbw_threads_stop(others);
                pbw_threads_stop(threads);
                CHECK(m.blocks == 0 && m.bytes == 0 && m.faults == 0);
                threads_allowed = -1;
            }
            five.run = run_backwards;
            five.run_user = &calls;
            CHECK(pbw_threads_start(&five, count, &inner) == NULL && inner.run == run_backwards);
            one.threads = -1;
            CHECK(pbw_threads_start(&one, count, &inner) == NULL && inner.threads == -1);
            CHECK(pbw_threads_start(NULL, 0, &inner) == NULL && inner.run == NULL);
            pbw_threads_stop(NULL);
            pbw_free(&right);
            points_free(&p);
            test_end();
        }
    }
}

static void sleep_until_report(void)
{
    const struct timespec rest = { 0, 1000000 };
    double start = pbw__seconds();
    while (pbw__seconds() - start < 0.021) {
        nanosleep(&rest, NULL);
    }
}

/* Progress, when the caller's thread comes to the last task first, and it is time for a report then. */
static void run_late(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    sleep_until_report();
    run_backwards(user, tasks, task, arg);
}

/* On the caller's thread, although it is always time for a report when others come to ask. */
static int watch_slowly(void *user, pbw_stage stage, double done)
{
    sleep_until_report();
    return watch_progress(user, stage, done);
}

static void test_progress(size_t count)
{
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("progress goes forward: %dD", dim)) {
            points p = points_make(INPUT_GAUSS, dim, count, INPUT_WEIGHTS_ZERO);
            pbw_options options = with_threads(5);
            pbw_mesh mesh;
            pbw_report report;
            watch w;
            long calls = 0;
            options.run = run_late;
            options.run_user = &calls;
            options.progress = watch_progress;
            options.progress_user = &w;
            watch_start(&w, 0);
            CHECK_EQUAL(pbw_triangulate(dim, p.x, NULL, p.count, &options, &mesh), PBW_OK);
            CHECK(w.wrong == 0 && w.done == 1 && w.stage == PBW_STAGE_OUTPUT && w.calls > 10);
            watch_start(&w, 0);
            CHECK(pbw_check(&mesh, &options, &report) == PBW_OK && report.valid);
            CHECK(w.wrong == 0 && w.done == 1 && w.stage == PBW_STAGE_CHECK);
            pbw_free(&mesh);
            options.run = NULL;
            options.progress = watch_slowly;
            watch_start(&w, 0);
            CHECK_EQUAL(pbw_triangulate(dim, p.x, NULL, p.count, &options, &mesh), PBW_OK);
            CHECK(w.wrong == 0 && w.done == 1 && w.stage == PBW_STAGE_OUTPUT);
            pbw_free(&mesh);
            points_free(&p);
            test_end();
        }
    }
    /* Only points like these take the outermost vertices of runs first.  Tasks must not read the last report while
       the caller's thread writes it, as it does each time if its callback is slow: ThreadSanitizer sees that. */
    if (test_begin("progress goes forward: lines")) {
        points p = points_make(INPUT_LINES, 3, 20000, INPUT_WEIGHTS_ZERO);
        pbw_options options = with_threads(4);
        pbw_mesh mesh;
        watch w;
        options.progress = watch_slowly;
        options.progress_user = &w;
        watch_start(&w, 0);
        CHECK_EQUAL(pbw_triangulate(3, p.x, NULL, p.count, &options, &mesh), PBW_OK);
        CHECK(w.wrong == 0 && w.done == 1 && w.stage == PBW_STAGE_OUTPUT);
        pbw_free(&mesh);
        points_free(&p);
        test_end();
    }
}

/* So many points that their order takes several reports: a slow callback is asked each time. */
static void test_cancelled_order(void)
{
    if (test_begin("cancelled while points are put into order")) {
        points p = points_make(INPUT_UNIFORM, 2, 150000, INPUT_WEIGHTS_ZERO);
        pbw_options options = with_threads(1);
        pbw_mesh mesh;
        watch w;
        long at;
        options.progress = watch_slowly;
        options.progress_user = &w;
        for (at = 1; at <= 4; at++) {
            watch_start(&w, at);
            CHECK_EQUAL(pbw_triangulate(2, p.x, NULL, p.count, &options, &mesh), PBW_CANCELLED);
            CHECK(meshes_is_empty(&mesh) && w.calls == at && w.stage == PBW_STAGE_ORDER);
        }
        points_free(&p);
        test_end();
    }
}

static void test_refused_threads(size_t count)
{
    long allowed;
    if (test_begin("fewer threads than asked for")) {
        points p = points_make(INPUT_BALL, 3, count, INPUT_WEIGHTS_ZERO);
        pbw_options one = with_threads(1);
        pbw_mesh right;
        CHECK_EQUAL(pbw_triangulate(3, p.x, NULL, p.count, &one, &right), PBW_OK);
        for (allowed = 0; allowed < 4; allowed++) {
            pbw_options eight = with_threads(8);
            pbw_mesh mesh;
            threads_allowed = allowed;
            compare(&p, eight, &right);
            threads_allowed = allowed;
            CHECK_EQUAL(pbw_triangulate(3, p.x, NULL, p.count, &eight, &mesh), PBW_OK);
            CHECK_EQUAL(mesh.statistics.threads, allowed + 1);
            pbw_free(&mesh);
        }
        threads_allowed = -1;
        pbw_free(&right);
        points_free(&p);
        test_end();
    }
}

static void test_failing_memory(size_t count)
{
    int i;
    for (i = 0; i < 3; i++) {
        const int dim = i > 0 ? 3 : 2, lines = i == 2;       /* so many on lines that tasks insert their extremes */
        if (test_begin("every allocation fails on four threads: %dD%s", dim, lines ? " lines" : "")) {
            points p = points_make(lines ? INPUT_LINES : INPUT_UNIFORM, dim, lines ? 2 * count : count,
                                   lines ? INPUT_WEIGHTS_SMALL : INPUT_WEIGHTS_HIDING);
            long k, refused = 1, done = 0;
            for (k = 1; refused > 0 && k < 2000; k++) {
                meter m;
                pbw_mesh mesh;
                pbw_options options = with_threads(4);
                pbw_status status;
                meter_start(&m, k, (int)(k & 1));
                options.resize = meter_resize;
                options.resize_user = &m;
                status = pbw_triangulate(dim, p.x, p.w, p.count, &options, &mesh);
                refused = m.refused;
                /* Without the team of threads the work is done on one. */
                CHECK(status == PBW_ERROR_MEMORY || status == PBW_OK);
                CHECK(status == PBW_OK || (refused > 0 && meshes_is_empty(&mesh)));
                done += status == PBW_ERROR_MEMORY;
                pbw_free(&mesh);
                CHECK(m.blocks == 0 && m.bytes == 0 && m.faults == 0);
            }
            CHECK(done > 20);
            points_free(&p);
            test_end();
        }
    }
}

/* Who inserted what; and the counts agree with it. */
static void test_trace(size_t count)
{
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("trace: %dD", dim)) {
            points p = points_make(INPUT_UNIFORM, dim, count, INPUT_WEIGHTS_ZERO);
            uint32_t *trace = (uint32_t *)malloc(count * sizeof(uint32_t));
            size_t i, tasks = 0, rounds = 0, tries;
            pbw_options options = with_threads(5);
            pbw_mesh mesh;
            if (trace == NULL) {
                abort();
            }
            memcpy(p.x + (count - 1) * (size_t)dim, p.x, (size_t)dim * sizeof(double));     /* a duplicate */
            options.trace = trace;
            CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, count, &options, &mesh), PBW_OK);
            for (tries = 0; (mesh.statistics.postponed == 0 || mesh.statistics.rounds <= 2) && tries < 100; tries++) {
                /* Meeting is chance, and so in the plane, where few levels have tasks, is a third round. */
                pbw_free(&mesh);
                CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, count, &options, &mesh), PBW_OK);
            }
            for (i = 0; i < count; i++) {
                CHECK((trace[i] == PBW_NONE) == (mesh.canonical[i] != i));
                if (trace[i] != PBW_NONE) {
                    tasks = trace[i] % 256 > tasks ? trace[i] % 256 : tasks;
                    rounds = trace[i] / 256 > rounds ? trace[i] / 256 : rounds;
                }
            }
            CHECK_EQUAL(mesh.statistics.threads, 5);
            CHECK(mesh.statistics.rounds > 2 && mesh.statistics.rounds <= rounds + 1);
            CHECK(mesh.statistics.postponed > 0 && mesh.statistics.serial > 0 && mesh.statistics.serial < count);
            pbw_free(&mesh);
            free(trace);
            CHECK(tasks > 0 && tasks < 5);
            points_free(&p);
            test_end();
        }
    }
}

#ifndef PBW_NO_SIMD
/* Terrain has more tetrahedra than there are slots, so a round ends early.  The store then grows enough for the rest:
   a second early end would make 94 % of the vertices wait.  Tasks run one after another, so chance has no part. */
static void test_growth(void)
{
    const size_t count = 100000;
    if (test_begin("a store that grows once: terrain")) {
        points p = points_make(INPUT_TERRAIN, 3, count, INPUT_WEIGHTS_ZERO);
        pbw_options options = with_threads(4);
        pbw_mesh mesh;
        long calls = 0;
        options.run = run_backwards;
        options.run_user = &calls;
        CHECK_EQUAL(pbw_triangulate(3, p.x, p.w, count, &options, &mesh), PBW_OK);
        CHECK(mesh.statistics.postponed > count / 2 && mesh.statistics.postponed < count / 10 * 9);
        pbw_free(&mesh);
        points_free(&p);
        test_end();
    }
}
#endif

/* A facet of a new simplex borders one that was tested and found outside; a lattice is full of ties, random points
   have none. */
static void test_counts(size_t count)
{
    int dim, lattice, threads;
    for (dim = 2; dim <= 3; dim++) {
        for (lattice = 0; lattice <= 1; lattice++) {
            if (test_begin("counts of tests: %dD %s", dim, lattice ? "lattice" : "uniform")) {
                points p = points_make(lattice ? INPUT_LATTICE : INPUT_UNIFORM, dim, count, INPUT_WEIGHTS_ZERO);
                for (threads = 1; threads <= 4; threads += 3) {
                    pbw_options options = with_threads(threads);
                    pbw_mesh mesh;
                    const pbw_statistics *made = &mesh.statistics;
                    CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, count, &options, &mesh), PBW_OK);
                    CHECK(made->conflict_tests >= made->created && made->conflict_tests < 3 * made->created);
                    CHECK(lattice ? made->exact_tests > (dim == 3 ? 4u : 1u) * count : made->exact_tests < count / 100);
                    CHECK(made->exact_tests < made->conflict_tests);
                    pbw_free(&mesh);
                }
                points_free(&p);
                test_end();
            }
        }
    }
}

/* One report, whoever finds the fault; returns whether there is one. */
static int same_report(const pbw_mesh *mesh)
{
    static const int threads[] = { 2, 3, 7, 16 };
    pbw_options options = with_threads(1);
    pbw_report right, report;
    size_t t;
    CHECK_EQUAL(pbw_check(mesh, &options, &right), PBW_OK);
    for (t = 0; t < sizeof threads / sizeof threads[0]; t++) {
        options = with_threads(threads[t]);
        CHECK_EQUAL(pbw_check(mesh, &options, &report), PBW_OK);
        CHECK(report.valid == right.valid && strcmp(report.what, right.what) == 0);
        CHECK(report.simplex == right.simplex && report.facet == right.facet && report.point == right.point);
        CHECK(report.vertex_count == right.vertex_count && report.facet_count == right.facet_count
              && report.hull_facet_count == right.hull_facet_count);
    }
    return !right.valid;
}

static void test_same_report(size_t count)
{
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("same report: %dD", dim)) {
            points p = points_make(INPUT_CLUSTERS, dim, count, INPUT_WEIGHTS_HIDING);
            pbw_options one = with_threads(1);
            pbw_mesh mesh;
            size_t fault, entries, faults = 0;
            CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, p.count, &one, &mesh), PBW_OK);
            entries = mesh.simplex_count * (size_t)(dim + 1);
            for (fault = 0; fault < 60; fault++) {
                pbw_index *array = (pbw_index *)(uintptr_t)(fault % 4 == 0 ? mesh.simplices
                                                            : fault % 4 == 1 ? mesh.neighbors
                                                            : fault % 4 == 2 ? mesh.incident : mesh.canonical);
                size_t length = fault % 4 < 2 ? entries : mesh.point_count, i = fault * 7919 % length;
                size_t j = (i + length / 2) % length;
                pbw_index old_i = array[i], old_j = array[j];
                array[i] = old_j;                    /* two faults: the first is to be told */
                array[j] = old_i;
                if (fault % 8 == 0) {
                    array[i] = array[j] = (pbw_index)mesh.point_count + 1000000;    /* corners that are no points */
                }
                faults += (size_t)same_report(&mesh);
                array[i] = old_i;
                array[j] = old_j;
            }
            CHECK(faults > 40);
            pbw_free(&mesh);
            points_free(&p);
            test_end();
        }
    }
}

/* Hidden points that are not: raised, outside, at a vertex, or at the place of another. */
static void test_hidden_report(size_t count)
{
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("same report of hidden points: %dD", dim)) {
            points p = points_make(INPUT_UNIFORM, dim, count, INPUT_WEIGHTS_HALF);
            pbw_options one = with_threads(1);
            pbw_mesh mesh;
            size_t i, k, seen = 0, last = 0, of[4] = { 0, 0, 0, 0 };
            CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, p.count, &one, &mesh), PBW_OK);
            CHECK(mesh.hidden_count > 100 && !same_report(&mesh));
            for (i = 0; i < count && seen < 60; i++) {
                double *x = (double *)(uintptr_t)mesh.points + i * (size_t)dim, kept[4];
                double *w = (double *)(uintptr_t)mesh.weights + i;
                const double *other = mesh.points + last * (size_t)dim;
                if (mesh.canonical[i] != i || mesh.incident[i] != PBW_NONE) {
                    continue;
                }
                memcpy(kept, x, (size_t)dim * sizeof(double));
                kept[dim] = *w;
                if (seen % 4 == 0) {
                    *w += 1e6;
                } else if (seen % 4 == 1) {
                    x[0] = 1e6;
                } else {
                    other = seen % 4 == 2 ? mesh.points + mesh.simplices[i] * (size_t)dim : other;
                    for (k = 0; k < (size_t)dim; k++) {
                        x[k] = other[k];
                    }
                }
                of[seen++ % 4] += (size_t)same_report(&mesh);
                memcpy(x, kept, (size_t)dim * sizeof(double));
                *w = kept[dim];
                last = i;
            }
            CHECK(of[0] == 15 && of[1] == 15 && of[2] == 15 && of[3] == 15);
            pbw_free(&mesh);
            points_free(&p);
            test_end();
        }
    }
}

/* Points that are not flat, though the mesh says so: the first that shows it is named. */
static void test_flat_report(size_t count)
{
    int dim, line, threads;
    for (dim = 2; dim <= 3; dim++) {
        for (line = 0; line <= dim - 2; line++) {
            if (test_begin("flat: %dD%s", dim, line ? ", a line" : "")) {
                points p = points_make(INPUT_UNIFORM, dim, count, INPUT_WEIGHTS_ZERO);
                size_t last = (size_t)dim - 1, first = count / 3, second = count / 3 * 2, i;
                pbw_options options = with_threads(4);
                pbw_report report;
                pbw_mesh mesh;
                double *x;
                for (i = 0; i < count; i++) {
                    p.x[i * (size_t)dim + last] = p.x[i * (size_t)dim + (line ? 1 : last)] = 0;
                }
                CHECK_EQUAL(pbw_triangulate(dim, p.x, p.w, count, &options, &mesh), PBW_DEGENERATE);
                CHECK_EQUAL(pbw_check(&mesh, &options, &report), PBW_OK);
                CHECK(report.valid);
                x = (double *)(uintptr_t)mesh.points;
                x[first * (size_t)dim + (line ? 1 : last)] = 1;      /* of a line, this makes a plane */
                x[second * (size_t)dim + last] = 1;
                for (threads = 1; threads <= 16; threads += 5) {
                    options.threads = threads;
                    CHECK_EQUAL(pbw_check(&mesh, &options, &report), PBW_OK);
                    CHECK(!report.valid && report.point == (line ? second : first));
                }
                pbw_free(&mesh);
                points_free(&p);
                test_end();
            }
        }
    }
}

/* Many builds at once, each with threads of its own. */
typedef struct builder { const points *p; const pbw_mesh *right; long wrong; } builder;

static void *build_some(void *arg)
{
    builder *b = (builder *)arg;
    int i;
    for (i = 0; i < 4; i++) {
        pbw_options options = with_threads(2 + i);
        pbw_mesh mesh;
        b->wrong += pbw_triangulate(b->p->dim, b->p->x, b->p->w, b->p->count, &options, &mesh) != PBW_OK
                 || !meshes_equal(&mesh, b->right);
        pbw_free(&mesh);
    }
    return NULL;
}

static void test_many_builds(size_t count)
{
    if (test_begin("many builds at once")) {
        points p = points_make(INPUT_CLUSTERS, 3, count, INPUT_WEIGHTS_ZERO);
        pbw_options one = with_threads(1);
        pbw_mesh right;
        pthread_t thread[6];
        builder builders[6];
        int i;
        CHECK_EQUAL(pbw_triangulate(3, p.x, NULL, p.count, &one, &right), PBW_OK);
        for (i = 0; i < 6; i++) {
            builders[i].p = &p;
            builders[i].right = &right;
            builders[i].wrong = 0;
            if (pthread_create(&thread[i], NULL, build_some, &builders[i]) != 0) {
                abort();
            }
        }
        for (i = 0; i < 6; i++) {
            pthread_join(thread[i], NULL);
            CHECK_EQUAL(builders[i].wrong, 0);
        }
        pbw_free(&right);
        points_free(&p);
        test_end();
    }
}

/* With wide links slots may lie beyond 2^30, and their edges beyond 2^32: moves the slots of a small live triangulation
   there, into memory that is only address space but for these, flips an edge, and has all edges tested again. */
static void test_wide_flips(void)
{
#ifdef WIDE_SLOTS
    const size_t base = ((size_t)1 << 30) + 5, links = 4 * sizeof(pbw__link), corners = 4 * sizeof(pbw_index);
    const size_t sizes[4] = { corners, links, 1, 1 };
    double x[2 * 50];
    void *map[4];
    pbw__context context;
    pbw_mesh mesh;
    pbw_live *live;
    pbwl__core *core, old;
    size_t slots, i, t, flipped = 0, wrong = 0;
    unsigned k;
    if (!test_begin("flips in slots beyond 2^30")) {
        return;
    }
    input_fill(INPUT_UNIFORM, 2, 50, 1, x);
    CHECK_EQUAL(pbw_triangulate(2, x, NULL, 50, NULL, &mesh), PBW_OK);
    CHECK_EQUAL(pbw_live_create(&mesh, NULL, &live), PBW_OK);
    core = &live->core;
    slots = core->store.count;
    for (i = 0; i < 4; i++) {
        map[i] = mmap(NULL, (base + slots) * sizes[i], PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS
                      | MAP_NORESERVE, -1, 0);
        if (map[i] == MAP_FAILED) {
            test_skip("no address space");
            return;
        }
    }
    old = *core;
    memcpy((char *)map[0] + base * corners, core->store.corner, slots * corners);
    core->store.corner = core->kernel.corner = (pbw_index *)map[0];
    for (i = 4 * base; i < 4 * (base + slots); i++) {
        ((pbw__link *)map[1])[i] = core->store.link[i - 4 * base] + 4 * base;
    }
    core->store.link = core->kernel.link = (pbw__link *)map[1];
    core->store.mark = core->kernel.mark = (unsigned char *)map[2];
    core->touched = (unsigned char *)map[3];
    pbw__context_start(&context, &live->options, 0);
    context.memory = live->memory;
    core->kernel.context = &context;
    CHECK(pbw__grow_lists(&core->kernel, 100) && PBWL__CORE_GROW(core, edge, 1));
    for (t = base; t < base + slots && flipped == 0; t++) {
        const pbw_index *v = core->kernel.corner + 4 * t;
        for (k = 0; k < 3 && v[0] != PBW_NONE && v[2] != PBW__GHOST && flipped == 0; k++) {
            const size_t u = (size_t)(core->kernel.link[4 * t + k] >> 2);
            if (core->kernel.corner[4 * u + 2] != PBW__GHOST && pbwl__flip(core, t, k) == PBW_OK) {
                unsigned edge;
                for (edge = 0; edge < 3; edge++) {
                    if ((size_t)(core->kernel.link[4 * t + edge] >> 2) == u) {
                        core->edge[0] = (pbw__link)(4 * t + edge);
                    }
                }
                flipped++;
                CHECK_EQUAL(pbwl__flip_all(core, 1, 100), PBW_OK);
            }
        }
    }
    CHECK_EQUAL(flipped, 1);
    for (i = 4 * base; i < 4 * (base + slots); i++) {
        const size_t s = i / 4;
        if (i % 4 < 3 && core->kernel.corner[4 * s] != PBW_NONE) {
            const pbw__link back = core->kernel.link[i];
            const pbw_index far = core->kernel.corner[back];
            wrong += core->kernel.link[back] != i;
            wrong += far != PBW__GHOST && core->kernel.corner[4 * s + 2] != PBW__GHOST
                  && pbw__simplex_conflict(&core->kernel, (pbw_index)s, pbwl__core_record(core, far));
        }
    }
    CHECK_EQUAL(wrong, 0);
    core->store = old.store;
    core->touched = old.touched;
    core->kernel.corner = old.kernel.corner;
    core->kernel.link = old.kernel.link;
    core->kernel.mark = old.kernel.mark;
    live->memory = context.memory;
    pbw_live_free(live);
    for (i = 0; i < 4; i++) {
        munmap(map[i], (base + slots) * sizes[i]);
    }
    pbw_free(&mesh);
    test_end();
#endif
}

/* More simplices than can be numbered, with a limit so low that small inputs reach it, and odd, as a new point of the
   plane takes two. */
static void test_limit(int dim, int kind)
{
    const size_t limit = simplex_limit;
    double x[3 * 2000];
    size_t n, refused = 0, done = 0;
    if (!test_begin("more than 2999 simplices, ghosts included: %dD %s", dim, input_name(kind))) {
        return;
    }
    simplex_limit = 2999;
    for (n = 10; n <= 2000; n += n / 8) {
        meter m;
        pbw_mesh mesh;
        pbw_options options;
        pbw_status status;
        meter_start(&m, 0, 0);
        memset(&options, 0, sizeof options);
        options.resize = meter_resize;
        options.resize_user = &m;
        options.threads = 1 + (int)(n % 2) * 2;
        input_fill(kind, dim, n, test_seed, x);
        status = pbw_triangulate(dim, x, NULL, n, &options, &mesh);
        if (status == PBW_OK) {
            CHECK(mesh.simplex_count <= simplex_limit && meshes_fault(&mesh) == NULL);
            done++;
        } else {
            CHECK_EQUAL(status, PBW_ERROR_TOO_LARGE);
            CHECK(meshes_is_empty(&mesh));
            refused++;
        }
        pbw_free(&mesh);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    CHECK(refused > 0 && done > 0);
    simplex_limit = limit;
    test_end();
}

int main(int argc, char **argv)
{
    size_t count;
    int dim, kind;
    test_start(argc, argv, COUNT);
    count = (size_t)test_count;
    test_same_bytes(count);
    test_shared_threads(count);
    test_job_systems(count);
    test_progress(count);
    test_cancelled_order();
    test_refused_threads(count);
    test_failing_memory(count < 2000 ? count / 2 : count < 6000 ? 1000 : count / 6);     /* hundreds of builds */
    test_trace(count < 5000 ? 5000 : count);         /* in the plane fewer have but one level with rounds */
#ifndef PBW_NO_SIMD
    test_growth();
#endif
    test_counts(count);
    test_same_report(count);
    test_hidden_report(1000);                        /* few, so that many are the first of a part */
    test_flat_report(count);
    test_many_builds(count);
    test_wide_flips();
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            test_limit(dim, kind);
        }
    }
    return test_finish();
}
