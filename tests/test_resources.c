/* test_resources.c: memory that runs out at any time, memory limits and ceilings, cancelling at any time, small
   stacks, quadratic outputs. */
#if defined(__linux__) || defined(__APPLE__)
#define _GNU_SOURCE
#endif
#include "pbw_check.h"
#include "meshes.h"
#include "meter.h"
#include "test.h"
#include "watch.h"

static pbw_options metered(meter *m, int threads)
{
    pbw_options options;
    memset(&options, 0, sizeof options);
    options.threads = threads;
    options.resize = meter_resize;
    options.resize_user = m;
    return options;
}

static void check_empty(const meter *m)
{
    CHECK_EQUAL(m->blocks, 0);
    CHECK_EQUAL(m->bytes, 0);
    CHECK_EQUAL(m->faults, 0);
}

/* --- failing allocations --- */

static long survived;

/* Refuses the k-th request, for every k until nothing is refused any more; and all later ones never, or always.  Of
   large inputs it refuses every third request, and all later ones in turn never and always. */
enum { ONE_FAILS, LATER_FAIL, EVERY_OTHER };

static void check_refusals(const zoo_input *in, int threads, int later)
{
    pbw_mesh right;
    pbw_status expected = meshes_make(in, NULL, &right), status;
    long k;
    for (k = 1; k < 100000; k += later == EVERY_OTHER ? 3 : 1) {
        meter m;
        pbw_mesh mesh;
        pbw_options options;
        meter_start(&m, k, later == EVERY_OTHER ? (int)(k & 1) : later);
        options = metered(&m, threads);
        status = meshes_make(in, &options, &mesh);
        if (m.refused == 0) {
            CHECK_EQUAL(status, expected);
            CHECK(meshes_equal(&mesh, &right));
            pbw_free(&mesh);
            check_empty(&m);
            break;
        }
        survived += m.refused;
        if (status == expected) {                     /* it may do without, say keep a block it wanted to shrink */
            CHECK(meshes_equal(&mesh, &right));
            pbw_free(&mesh);
        } else {
            CHECK_EQUAL(status, PBW_ERROR_MEMORY);
            CHECK(meshes_is_empty(&mesh));
        }
        check_empty(&m);
        if (test_faults > 0) {
            test_say("%d threads: request %ld refused%s", threads, k, m.fail_all_after ? ", and all later" : "");
            break;
        }
    }
    for (k = 1; k < 100000 && (expected == PBW_OK || expected == PBW_DEGENERATE);
         k += later == EVERY_OTHER ? 3 : 1) {
        meter m;
        pbw_report report;
        pbw_options options;
        meter_start(&m, k, later == EVERY_OTHER ? (int)(k & 1) : later);
        options = metered(&m, threads);
        memset(&report, 0, sizeof report);
        status = pbw_check(&right, &options, &report);
        survived += m.refused;
        check_empty(&m);
        if (m.refused == 0) {
            CHECK(status == PBW_OK && report.valid);
            break;
        }
        CHECK_EQUAL(status, PBW_ERROR_MEMORY);
    }
    pbw_free(&right);
}

static void test_refusals(void)
{
    zoo animals;
    size_t i;
    zoo_fill(&animals);
    zoo_kind(&animals, 2, INPUT_UNIFORM, TEST_SIZE(2000));
    zoo_kind(&animals, 3, INPUT_UNIFORM, TEST_SIZE(2000));
    zoo_kind(&animals, 3, INPUT_MOMENT, TEST_SIZE(150));
    zoo_kind(&animals, 3, INPUT_LINES, 4000);         /* has stars so large that extremes come before a level */
    for (i = 0; i < animals.count; i++) {
        const zoo_input *in = animals.items + i;
        const int large = i + 4 >= animals.count;
        if ((in->count <= 130 || large) && test_begin("every allocation fails: %s", in->name)) {
            if (i + 1 < animals.count) {             /* those on lines have more requests than all others together */
                check_refusals(in, 1, large ? EVERY_OTHER : ONE_FAILS);
            }
            check_refusals(in, large ? 3 : 1, large ? EVERY_OTHER : LATER_FAIL);
            if (!large && i % 8 == 0) {
                check_refusals(in, 3, ONE_FAILS);
                check_refusals(in, 3, LATER_FAIL);
            }
            test_end();
        }
    }
    if (test_verbose) {
        test_say("%ld refused allocations survived", survived);
    }
    zoo_free(&animals);
}

/* --- how much is held --- */

static void test_ceilings(void)
{
    /* bytes a point of uniform points, without weights, with, and borrowed.  At the peak: the tables of README and
       bench/README; 0.5 MB a thread come on top.  In the result: as pbw.h says. */
    static const double at_peak[2][3] = { { 84, 92, 84 }, { 266, 266, 258 } };
    static const double in_result[2][3] = { { 85, 85, 69 }, { 260, 260, 236 } };
    size_t n = 200000;
    double *points = (double *)zoo_grow(NULL, n * 3 * sizeof *points);
    double *weights = (double *)zoo_grow(NULL, n * sizeof *weights);
    int dim, threads, weighted;                          /* 2: PBW_BORROW, without weights */
    for (dim = 2; dim <= 3; dim++) {
        for (threads = 1; threads <= 4; threads += 3) {
            for (weighted = 0; weighted <= 2; weighted++) {
                const char *what = weighted == 2 ? ", borrowed" : weighted ? ", weighted" : "";
                double each, result;
                meter m;
                pbw_mesh mesh;
                pbw_options options;
                if (!test_begin("bytes a point: %dD, %d threads%s", dim, threads, what)) {
                    continue;
                }
                meter_start(&m, 0, 0);
                options = metered(&m, threads);
                options.flags = weighted == 2 ? PBW_BORROW : 0;
                input_fill(INPUT_UNIFORM, dim, n, test_seed, points);
                input_fill_weights(INPUT_WEIGHTS_SMALL, dim, n, test_seed, points, weights);
                CHECK_EQUAL(pbw_triangulate(dim, points, weighted == 1 ? weights : NULL, n, &options, &mesh), PBW_OK);
                each = (double)m.peak / (double)n;
                result = (double)m.bytes / (double)n;
                printf("    %dD, %d threads%s: %.1f bytes a point held at once, %.1f in the result\n", dim,
                       threads, what, each, result);
                CHECK(each <= at_peak[dim - 2][weighted] + 0.5e6 * threads / (double)n);
                CHECK(result <= in_result[dim - 2][weighted]);
                if (threads == 1) {
                    CHECK_EQUAL(mesh.statistics.peak_bytes, m.peak);
                } else {                             /* counted before it is there, and until it is gone */
                    CHECK(mesh.statistics.peak_bytes >= m.peak);
                    CHECK((double)mesh.statistics.peak_bytes <= (double)m.peak + 0.5e6 * threads);
                }
                pbw_free(&mesh);
                check_empty(&m);
                test_end();
            }
        }
    }
    free(points);
    free(weights);
}

static void test_limits(void)
{
    static const int kinds[4] = { INPUT_UNIFORM, INPUT_LATTICE, INPUT_CLUSTERS, INPUT_MOMENT };
    enum { MANY = TEST_SIZE(1500) };
    double points[3 * MANY];
    int i, threads;
    size_t n = MANY;
    for (i = 0; i < 8; i++) {
        int dim = 2 + i % 2, kind = kinds[i / 2];
        if (test_begin("memory limit: %dD %s", dim, input_name(kind))) {
            n = kind == INPUT_MOMENT ? TEST_SIZE(200) : MANY;
            input_fill(kind, dim, n, test_seed, points);
            for (threads = 1; threads <= 4; threads += 3) {
                meter m;
                pbw_mesh mesh;
                pbw_status status;
                pbw_options options;
                size_t enough, limit;
                meter_start(&m, 0, 0);
                options = metered(&m, threads);
                CHECK_EQUAL(pbw_triangulate(dim, points, NULL, n, &options, &mesh), PBW_OK);
                enough = m.peak;
                pbw_free(&mesh);
                for (limit = 1; limit < 4 * enough; limit += limit / 5 + 1) {
                    meter_start(&m, 0, 0);
                    options = metered(&m, threads);
                    options.memory_limit = limit;
                    status = pbw_triangulate(dim, points, NULL, n, &options, &mesh);
                    CHECK(status == PBW_ERROR_MEMORY ? limit < enough && meshes_is_empty(&mesh) : status == PBW_OK);
                    CHECK(m.peak <= limit && mesh.statistics.peak_bytes <= limit);
                    pbw_free(&mesh);
                    check_empty(&m);
                }
            }
            test_end();
        }
    }
}

static void test_quadratic(void)
{
    size_t n = 1000;
    double *points = (double *)zoo_grow(NULL, n * 3 * sizeof *points);
    if (test_begin("quadratic output: 1000 points of the moment curve")) {
        meter m;
        pbw_mesh mesh;
        pbw_options options;
        input_fill(INPUT_MOMENT, 3, n, test_seed, points);
        meter_start(&m, 0, 0);
        options = metered(&m, 1);
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, n, &options, &mesh), PBW_OK);
        CHECK_EQUAL(mesh.simplex_count, (n - 2) * (n - 3) / 2);
        pbw_free(&mesh);
        check_empty(&m);
        options.memory_limit = m.peak / 3;
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, n, &options, &mesh), PBW_ERROR_MEMORY);
        CHECK(meshes_is_empty(&mesh));
        check_empty(&m);
        test_end();
    }
    free(points);
}

/* --- progress --- */

/* Cancels at the k-th call, for every k, or every third of large inputs, until the build or check is through. */
static void check_cancelling(const zoo_input *in, int threads, int checking)
{
    pbw_mesh right;
    pbw_status expected = meshes_make(in, NULL, &right), status;
    long k;
    for (k = 1; k < 1000; k += in->count > 2000 ? 3 : 1) {
        meter m;
        watch w;
        pbw_mesh mesh;
        pbw_report report;
        pbw_options options;
        meter_start(&m, 0, 0);
        watch_start(&w, k);
        options = metered(&m, threads);
        options.progress = watch_progress;
        options.progress_user = &w;
        memset(&mesh, 0, sizeof mesh);
        status = checking ? pbw_check(&right, &options, &report) : meshes_make(in, &options, &mesh);
        CHECK_EQUAL(w.wrong, 0);
        if (w.calls < k) {
            CHECK_EQUAL(status, checking ? PBW_OK : expected);
            CHECK(w.calls == 0 || w.done == 1);
            CHECK(checking || meshes_equal(&mesh, &right));
            CHECK_EQUAL(w.stages, checking ? 1 << PBW_STAGE_CHECK
                                           : 1 << PBW_STAGE_ORDER | 1 << PBW_STAGE_BUILD | 1 << PBW_STAGE_OUTPUT);
            pbw_free(&mesh);
            check_empty(&m);
            break;
        }
        CHECK_EQUAL(w.calls, k);                      /* never called again */
        CHECK_EQUAL(status, PBW_CANCELLED);
        CHECK(checking || meshes_is_empty(&mesh));
        check_empty(&m);
        if (test_faults > 0) {
            test_say("%d threads, %s, cancelled at call %ld", threads, checking ? "check" : "build", k);
            break;
        }
    }
    if (test_verbose) {
        test_say("%ld calls", k - 1);
    }
    pbw_free(&right);
}

static void test_progress(void)
{
    zoo animals;
    size_t i;
    zoo_fill(&animals);
    zoo_kind(&animals, 2, INPUT_UNIFORM, TEST_SIZE(40000));
    zoo_kind(&animals, 3, INPUT_UNIFORM, TEST_SIZE(15000));
    zoo_kind(&animals, 3, INPUT_SPHERE, TEST_SIZE(8000));
    zoo_kind(&animals, 3, INPUT_LINES, TEST_SIZE(10000));
    for (i = 0; i < animals.count; i++) {
        const zoo_input *in = animals.items + i;
        if (in->finite && in->count > 0 && (i % 8 == 0 || i + 4 >= animals.count)
            && test_begin("cancelled: %s", in->name)) {
            check_cancelling(in, 1, 0);
            check_cancelling(in, 3, 0);
            check_cancelling(in, 1, 1);
            test_end();
        }
    }
    zoo_free(&animals);
}

/* --- a small stack --- */

#define STACK_BYTES ((size_t)256 * 1024)

typedef struct stack_job {
    const zoo *animals;
    long wrong;
} stack_job;

static void *run_on_small_stack(void *argument)
{
    stack_job *job = (stack_job *)argument;
    size_t i;
    for (i = 0; i < job->animals->count; i++) {
        pbw_mesh mesh;
        pbw_report report;
        pbw_options options;
        memset(&options, 0, sizeof options);
        options.threads = i % 4 == 0 ? 3 : 1;
        if (meshes_make(job->animals->items + i, &options, &mesh) <= PBW_DEGENERATE) {
            job->wrong += pbw_check(&mesh, &options, &report) != PBW_OK || !report.valid;
            (void)pbw_hash(&mesh, NULL);
        } else {
            job->wrong += job->animals->items[i].finite;
        }
        pbw_free(&mesh);
    }
    return NULL;
}

static void test_stack(void)
{
    zoo animals;
    stack_job job;
    pthread_t thread;
    pthread_attr_t attributes;
    size_t used = 0, start;
    unsigned char *block;
    int i;
    if (!test_begin("all on a stack of 256 KiB")) {
        return;
    }
    zoo_fill(&animals);
    zoo_kind(&animals, 3, INPUT_MOMENT, 700);
    zoo_kind(&animals, 3, INPUT_SPHERE, 20000);
    zoo_kind(&animals, 3, INPUT_LATTICE, 20000);
    zoo_new(&animals, 2, "many on a line, one off it");
    for (i = 0; i < 100000; i++) {
        zoo_add(&animals, i, 3.0 * i, 0);
    }
    zoo_add(&animals, 5, 5, 0);
    zoo_new(&animals, 3, "many on a line");
    for (i = 0; i < 100000; i++) {
        zoo_add(&animals, i, -i, 2.0 * i);
    }
    zoo_new(&animals, 2, "many on a circle");
    zoo_ring(&animals, 100000, 1, 0);
    zoo_new(&animals, 3, "many at one place");
    for (i = 0; i < 100000; i++) {
        zoo_add(&animals, 1, 2, 3);
    }
    job.animals = &animals;
    job.wrong = 0;
    block = (unsigned char *)zoo_grow(NULL, 2 * STACK_BYTES + 65536);
    memset(block, 0x5c, 2 * STACK_BYTES + 65536);
    start = 65536 - (uintptr_t)block % 65536;
    pthread_attr_init(&attributes);
#if defined(TEST_SANITIZED)
    pthread_attr_setstacksize(&attributes, 4 * STACK_BYTES);     /* their frames are larger */
#else
    CHECK(pthread_attr_setstack(&attributes, block + start + STACK_BYTES, STACK_BYTES) == 0);
#endif
    if (CHECK(pthread_create(&thread, &attributes, run_on_small_stack, &job) == 0)) {
        pthread_join(thread, NULL);
        CHECK_EQUAL(job.wrong, 0);
        while (used < 2 * STACK_BYTES && block[used] == 0x5c) {
            used++;
        }
        used = start + 2 * STACK_BYTES - used;
        CHECK(used < STACK_BYTES);
        if (test_verbose) {
            test_say("%zu bytes of it used", used);
        }
    }
    pthread_attr_destroy(&attributes);
    free(block);
    zoo_free(&animals);
    test_end();
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 0);
    test_refusals();
    test_ceilings();
    test_limits();
    test_quadratic();
    test_progress();
    test_stack();
    return test_finish();
}
