/* test_api.c: every awkward call has a defined answer, nothing is shared between calls, and the state of the
   floating-point unit neither harms nor is harmed. */
#if defined(__linux__) || defined(__APPLE__)
#define _GNU_SOURCE
#define TEST_GUARD_PAGES
#include <sys/mman.h>
#include <unistd.h>
#endif
#include "pbw_check.h"
#include "meshes.h"
#include "test.h"

#include <fenv.h>
#include <pthread.h>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

static const double five[15] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1 };

/* Fails cleanly: that status, and an empty mesh. */
static void check_refused(int dim, const double *points, const double *weights, size_t count,
                          const pbw_options *options, pbw_status expected)
{
    const float *f = (const float *)(const void *)points, *g = (const float *)(const void *)weights;
    pbw_mesh mesh;
    memset(&mesh, 0x5a, sizeof mesh);
    CHECK_EQUAL(pbw_triangulate(dim, points, weights, count, options, &mesh), expected);
    CHECK(meshes_is_empty(&mesh));
    memset(&mesh, 0x5a, sizeof mesh);
    CHECK_EQUAL(pbw_triangulatef(dim, f, g, count, options, &mesh), expected);
    CHECK(meshes_is_empty(&mesh));
    pbw_free(&mesh);
}

/* A backend for tests: does as its plan says. */
typedef struct fake_plan {
    int keep_first, reserve, decline, calls;
    pbw_status status;
} fake_plan;

static pbw_status fake_triangulate(const pbw_backend *backend, pbw_job *job)
{
    fake_plan *plan = (fake_plan *)backend->user;
    pbw_status status;
    size_t i;
    plan->calls++;
    CHECK(job->dim == 3 && job->count == 5 && job->points != NULL && job->weights == NULL);
    CHECK(job->stride == 3 * (job->is_float ? sizeof(float) : sizeof(double)));
    if (plan->keep_first) {
        status = job->keep(job);
        if (status == PBW_ERROR_MEMORY && job->memory_limit > 0) {
            return status;
        }
        CHECK_EQUAL(status, PBW_OK);
        CHECK(job->kept_points != NULL && job->kept_weights == NULL);
    }
    if (plan->reserve) {
        status = job->reserve(job, 1);
        if (status != PBW_OK) {
            return status;
        }
        CHECK((job->neighbors == NULL) == ((job->flags & PBW_NO_NEIGHBORS) != 0));
        for (i = 0; i < 4; i++) {                    /* not the triangulation, but arrays that can be recognised */
            job->simplices[i] = (pbw_index)i;
            if (job->neighbors != NULL) {
                job->neighbors[i] = PBW_NONE;
            }
        }
        for (i = 0; i < 5; i++) {
            job->incident[i] = i < 4 ? 0 : PBW_NONE;
            job->canonical[i] = (pbw_index)i;
        }
        job->hidden_count = 1;
    }
    if (job->report(job, PBW_STAGE_BUILD, 0.5)) {
        return PBW_CANCELLED;
    }
    job->say(job, "17 bytes are missing");
    job->declined = plan->decline;
    return plan->status;
}

/* A backend that is to find its job as it was asked for, weighted points with gaps; it says texts of many lengths. */
static pbw_status look_triangulate(const pbw_backend *backend, pbw_job *job)
{
    const pbw_options *options = (const pbw_options *)backend->user;
    const char *text = "123456789";
    size_t length;
    CHECK(job->dim == 2 && !job->is_float && job->count == 3 && job->points == five);
    CHECK(job->weights == five + 3 && job->stride == options->stride && job->weight_stride == options->weight_stride);
    CHECK(job->threads == options->threads && job->memory_limit == options->memory_limit);
    CHECK_EQUAL(job->flags, options->flags);
    for (length = 0; length < 10; length++) {        /* the last byte is not ours */
        memset(options->message, '!', 9);
        job->say(job, text + 9 - length);
        CHECK(strncmp(options->message, text + 9 - length, 7) == 0);
        CHECK(options->message[length < 7 ? length : 7] == '\0' && options->message[8] == '!');
    }
    CHECK_EQUAL(job->reserve(job, PBW_NONE), PBW_ERROR_TOO_LARGE);
    return PBW_ERROR_BACKEND;
}

static void test_backend_job(void)
{
    if (test_begin("backend: what it is given")) {
        pbw_options options;
        pbw_backend backend;
        pbw_mesh mesh;
        char message[9];
        memset(&options, 0, sizeof options);
        options.threads = 3;
        options.flags = PBW_NO_NEIGHBORS | PBW_ANY_ORDER;
        options.stride = 3 * sizeof(double);
        options.weight_stride = 4 * sizeof(double);
        options.memory_limit = 12345678;
        options.message = message;
        options.message_size = 8;
        options.backend = &backend;
        backend.version = PBW_VERSION;
        backend.triangulate = look_triangulate;
        backend.user = &options;
        CHECK_EQUAL(pbw_triangulate(2, five, five + 3, 3, &options, &mesh), PBW_ERROR_BACKEND);
        CHECK(meshes_is_empty(&mesh));
        test_end();
    }
}

static void test_backends(void)
{
    fake_plan plan;
    pbw_backend backend;
    pbw_options options;
    pbw_mesh mesh, cpu;
    char message[8];
    uint32_t trace[5];
    int i, j;
    memset(&options, 0, sizeof options);
    memset(&plan, 0, sizeof plan);
    backend.version = PBW_VERSION;
    backend.triangulate = fake_triangulate;
    backend.user = &plan;
    options.backend = &backend;
    options.message = message;
    options.message_size = sizeof message;
    CHECK_EQUAL(pbw_triangulate(3, five, NULL, 5, NULL, &cpu), PBW_OK);
    if (test_begin("backend: of another version, or without a function")) {
        backend.version = PBW_VERSION + 1;
        check_refused(3, five, NULL, 5, &options, PBW_ERROR_BACKEND);
        CHECK_EQUAL(strcmp(message, "the bac"), 0);  /* cut to fit */
        backend.version = PBW_VERSION;
        backend.triangulate = NULL;
        check_refused(3, five, NULL, 5, &options, PBW_ERROR_BACKEND);
        backend.triangulate = fake_triangulate;
        test_end();
    }
    if (test_begin("backend: its arrays are the mesh")) {
        for (i = 0; i < 4; i++) {
            plan.keep_first = i & 1;
            plan.reserve = 1;
            options.flags = (i & 2) != 0 ? PBW_NO_NEIGHBORS : 0;
            options.trace = trace;
            memset(trace, 0, sizeof trace);
            CHECK_EQUAL(pbw_triangulate(3, five, NULL, 5, &options, &mesh), PBW_OK);
            for (j = 0; j < 5; j++) {
                CHECK_EQUAL(trace[j], PBW_NONE);
            }
            CHECK(mesh.statistics.by_backend == 1 && mesh.simplex_count == 1 && mesh.hidden_count == 1);
            CHECK(mesh.simplices[3] == 3 && mesh.incident[4] == PBW_NONE && mesh.canonical[4] == 4);
            CHECK((mesh.neighbors == NULL) == ((i & 2) != 0));
            CHECK(memcmp(mesh.points, five, sizeof(double) * 15) == 0);
            pbw_free(&mesh);
        }
        options.flags = 0;
        options.trace = NULL;
        test_end();
    }
    if (test_begin("backend: little memory")) {      /* less than the 864 bytes that are asked for on a guess */
        plan.keep_first = plan.reserve = 1;
        plan.status = PBW_OK;
        for (i = 64, j = 0; j == 0 && i < 4096; i += 16) {
            options.memory_limit = (size_t)i;
            if (pbw_triangulate(3, five, NULL, 5, &options, &mesh) == PBW_OK) {
                CHECK(mesh.simplex_count == 1 && mesh.statistics.peak_bytes <= (size_t)i);
                j = i;
            } else {
                CHECK(meshes_is_empty(&mesh));
            }
            pbw_free(&mesh);
        }
        CHECK(j > 0 && j < 864);
        options.memory_limit = 0;
        test_end();
    }
    if (test_begin("backend: fails, declines, is cancelled")) {
        for (i = 0; i < 8; i++) {
            plan.keep_first = i & 1;
            plan.reserve = (i & 2) != 0;
            plan.decline = 0;
            plan.status = PBW_ERROR_BACKEND;
            options.flags = 0;
            memset(message, 0, sizeof message);
            CHECK_EQUAL(pbw_triangulate(3, five, NULL, 5, &options, &mesh), PBW_ERROR_BACKEND);
            CHECK(meshes_is_empty(&mesh) && strcmp(message, "17 byte") == 0);
            options.flags = (i & 4) != 0 ? PBW_BACKEND_OR_CPU : 0;
            plan.decline = (i & 4) == 0;
            plan.calls = 0;
            CHECK_EQUAL(pbw_triangulate(3, five, NULL, 5, &options, &mesh), PBW_OK);
            CHECK(plan.calls == 1 && mesh.statistics.by_backend == 0 && meshes_equal(&mesh, &cpu));
            pbw_free(&mesh);
            plan.status = PBW_CANCELLED;
            CHECK_EQUAL(pbw_triangulate(3, five, NULL, 5, &options, &mesh), PBW_CANCELLED);
            CHECK(meshes_is_empty(&mesh));
        }
        test_end();
    }
    if (test_begin("backend: is not asked about no points")) {
        plan.calls = 0;
        CHECK_EQUAL(pbw_triangulate(3, NULL, NULL, 0, &options, &mesh), PBW_DEGENERATE);
        CHECK_EQUAL(plan.calls, 0);
        pbw_free(&mesh);
        test_end();
    }
    pbw_free(&cpu);
}

static void test_arguments(void)
{
    pbw_options options;
    pbw_mesh mesh;
    pbw_report report;
    int i;
    if (test_begin("arguments: dimension, NULL")) {
        for (i = -3; i <= 6; i++) {
            if (i != 2 && i != 3) {
                check_refused(i, five, NULL, 5, NULL, PBW_ERROR_ARGUMENT);
            }
        }
        check_refused(3, NULL, NULL, 5, NULL, PBW_ERROR_ARGUMENT);
        check_refused(2, NULL, five, 5, NULL, PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_triangulate(3, five, NULL, 5, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_triangulatef(3, NULL, NULL, 0, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_triangulate(3, NULL, NULL, 0, NULL, &mesh), PBW_DEGENERATE);
        CHECK_EQUAL(pbw_check(&mesh, NULL, &report), PBW_OK);
        CHECK_EQUAL(report.valid, 1);
        CHECK(pbw_hash(&mesh, NULL) == 0);
        pbw_free(&mesh);
        CHECK_EQUAL(pbw_check(NULL, NULL, &report), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_check(&mesh, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK(pbw_hash(NULL, NULL) == 0);
        test_end();
    }
    if (test_begin("arguments: flags, threads, strides")) {
        for (i = 5; i < 32; i++) {
            memset(&options, 0, sizeof options);
            options.flags = 1u << i;
            check_refused(3, five, NULL, 5, &options, PBW_ERROR_ARGUMENT);
        }
        for (i = -1; i <= 257; i += 258) {
            memset(&options, 0, sizeof options);
            options.threads = i;
            check_refused(3, five, NULL, 5, &options, PBW_ERROR_ARGUMENT);
        }
        for (i = 1; i < 24; i++) {
            memset(&options, 0, sizeof options);
            options.stride = (size_t)i;
            CHECK_EQUAL(pbw_triangulate(3, five, NULL, 5, &options, &mesh), PBW_ERROR_ARGUMENT);
            CHECK(meshes_is_empty(&mesh));
            options.stride = 0;
            options.weight_stride = (size_t)(i < 8 ? i : 1);
            CHECK_EQUAL(pbw_triangulate(3, five, five, 5, &options, &mesh), PBW_ERROR_ARGUMENT);
            CHECK(meshes_is_empty(&mesh));
        }
        for (i = 1; i < 8; i++) {
            float f[10] = { 0 };
            memset(&options, 0, sizeof options);
            options.stride = (size_t)i;
            CHECK_EQUAL(pbw_triangulatef(2, f, NULL, 5, &options, &mesh), PBW_ERROR_ARGUMENT);
        }
        test_end();
    }
    if (test_begin("arguments: more points than an index can number are not read")) {
        check_refused(3, five, NULL, (size_t)PBW_NONE, NULL, PBW_ERROR_TOO_LARGE);
        check_refused(2, five, five, (size_t)-1, NULL, PBW_ERROR_TOO_LARGE);
        check_refused(2, five, five, (size_t)-1 / 16, NULL, PBW_ERROR_TOO_LARGE);
        memset(&options, 0, sizeof options);
        options.stride = (size_t)-1 / 4;
        check_refused(3, five, NULL, 5, &options, PBW_ERROR_TOO_LARGE);
        options.stride = 0;
        options.weight_stride = (size_t)-1 / 4;
        check_refused(3, five, five, 5, &options, PBW_ERROR_TOO_LARGE);
        test_end();
    }
    if (test_begin("texts and version")) {
        for (i = PBW_OK; i <= PBW_ERROR_BACKEND; i++) {
            int j;
            CHECK(pbw_status_string((pbw_status)i)[0] != '\0');
            for (j = PBW_OK; j < i; j++) {
                CHECK(strcmp(pbw_status_string((pbw_status)i), pbw_status_string((pbw_status)j)) != 0);
            }
        }
        CHECK(pbw_status_string((pbw_status)15) != NULL);
        CHECK_EQUAL(pbw_version(), PBW_VERSION);
        test_end();
    }
    if (test_begin("free: of nothing, and twice")) {
        memset(&mesh, 0, sizeof mesh);
        pbw_free(&mesh);
        pbw_free(NULL);
        CHECK_EQUAL(pbw_triangulate(3, five, NULL, 5, NULL, &mesh), PBW_OK);
        pbw_free(&mesh);
        CHECK(meshes_is_empty(&mesh));
        pbw_free(&mesh);
        CHECK(meshes_is_empty(&mesh));
        test_end();
    }
}

/* Points right before an unreadable page: a read past the last one is a crash. */
static void test_reads(void)
{
    if (test_begin("reads nothing past the last point and weight")) {
#if defined(TEST_GUARD_PAGES)
        size_t page = (size_t)sysconf(_SC_PAGESIZE), n, stride;
        char *map = (char *)mmap(NULL, 4 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (CHECK(map != MAP_FAILED)) {
            CHECK(mprotect(map + page, page, PROT_NONE) == 0 && mprotect(map + 3 * page, page, PROT_NONE) == 0);
            for (n = 1; n <= 12; n++) {
                for (stride = 24; stride <= 32; stride += 8) {
                    double points[36];
                    char *at = map + page - (n - 1) * stride - 24;
                    double *weights = (double *)(void *)(map + 3 * page - n * 8);
                    pbw_options options;
                    pbw_mesh mesh;
                    size_t i;
                    memset(&options, 0, sizeof options);
                    options.stride = stride;
                    input_fill(INPUT_UNIFORM, 3, n, 1, points);
                    for (i = 0; i < n; i++) {
                        memcpy(at + i * stride, points + 3 * i, 24);
                    }
                    memset(weights, 0, n * 8);
                    CHECK_EQUAL(pbw_triangulate(3, (double *)(void *)at, weights, n, &options, &mesh),
                                n >= 4 ? PBW_OK : PBW_DEGENERATE);
                    pbw_free(&mesh);
                }
            }
            munmap(map, 4 * page);
        }
        test_end();
#else
        test_skip("no mmap here");
#endif
    }
}

/* --- few points, flat points, bad points --- */

static void check_degenerate(int dim, const double *points, size_t n, size_t places)
{
    int weighted;
    for (weighted = 0; weighted <= 1; weighted++) {
        double weights[64];
        pbw_mesh mesh;
        pbw_report report;
        size_t i, kept = 0;
        input_fill_weights(INPUT_WEIGHTS_LEVELS, dim, n, 1, points, weights);
        CHECK_EQUAL(pbw_triangulate(dim, points, weighted ? weights : NULL, n, NULL, &mesh), PBW_DEGENERATE);
        CHECK(mesh.dim == dim && mesh.point_count == n && mesh.simplex_count == 0);
        CHECK_EQUAL(mesh.duplicate_count, n - places);
        CHECK_EQUAL(mesh.hidden_count, 0);
        if (n > 0 && CHECK(mesh.canonical != NULL && mesh.incident != NULL && mesh.points != NULL)) {
            for (i = 0; i < n; i++) {
                CHECK(mesh.incident[i] == PBW_NONE && mesh.canonical[mesh.canonical[i]] == mesh.canonical[i]);
                kept += mesh.canonical[i] == i;
            }
            CHECK_EQUAL(kept, places);
            CHECK(memcmp(mesh.points, points, n * (size_t)dim * sizeof(double)) == 0);
            CHECK((mesh.weights != NULL) == (weighted != 0));
        }
        CHECK(pbw_check(&mesh, NULL, &report) == PBW_OK && report.valid);
        pbw_free(&mesh);
    }
}

static void test_small(void)
{
    double points[64 * 3];
    int dim, kind;
    size_t n, i;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("few points: %dD, 0 to 8, in general position", dim)) {
            for (n = 0; n <= 8; n++) {
                input_fill(INPUT_UNIFORM, dim, n, 5, points);
                if (n <= (size_t)dim) {
                    check_degenerate(dim, points, n, n);
                } else {
                    pbw_mesh mesh;
                    CHECK_EQUAL(pbw_triangulate(dim, points, NULL, n, NULL, &mesh), PBW_OK);
                    CHECK(mesh.simplex_count >= 1 && meshes_fault(&mesh) == NULL);
                    CHECK(memcmp(mesh.points, points, n * (size_t)dim * sizeof(double)) == 0 && mesh.weights == NULL);
                    pbw_free(&mesh);
                }
            }
            test_end();
        }
        for (kind = 0; kind < 4; kind++) {
            static const char *const names[4] = { "all equal", "two places", "on a line", "on a plane" };
            if ((kind < 3 || dim == 3) && test_begin("flat points: %dD, %s", dim, names[kind])) {
                for (n = 1; n <= 60; n++) {
                    for (i = 0; i < n; i++) {
                        double *p = points + i * (size_t)dim, a = (double)(i % 7), b = (double)(i / 7);
                        p[0] = kind == 0 ? 3 : kind == 1 ? (double)(i % 2) : (double)i;
                        p[1] = kind == 0 ? 4 : kind == 1 ? 1 : 2 * p[0] + 1;
                        p[dim - 1] = dim == 3 ? 7 - p[0] : p[1];
                        if (kind == 3) {
                            p[0] = a, p[1] = b, p[2] = a + b;
                        }
                    }
                    check_degenerate(dim, points, n, kind == 0 ? 1 : kind == 1 && n > 2 ? 2 : n);
                }
                test_end();
            }
        }
        if (test_begin("not finite: %dD, in each place", dim)) {
            static const double bad[3] = { NAN, INFINITY, -INFINITY };
            double weights[20];
            input_fill(INPUT_UNIFORM, dim, 20, 5, points);
            input_fill(INPUT_UNIFORM, 2, 10, 6, weights);
            for (i = 0; i < 3 * (20 * (size_t)dim + 20); i++) {
                size_t at = i / 3, coordinates = 20 * (size_t)dim;
                double *number = at < coordinates ? points + at : weights + (at - coordinates), kept = *number;
                pbw_mesh mesh;
                *number = bad[i % 3];
                CHECK_EQUAL(pbw_triangulate(dim, points, weights, 20, NULL, &mesh), PBW_ERROR_NOT_FINITE);
                CHECK(meshes_is_empty(&mesh));
                *number = kept;
            }
            test_end();
        }
        if (test_begin("not finite: %dD, floats", dim)) {
            float floats[60];
            for (i = 0; i < 20 * (size_t)dim; i++) {
                floats[i] = (float)points[i];
            }
            for (i = 0; i < 20 * (size_t)dim; i++) {
                pbw_mesh mesh;
                float kept = floats[i];
                floats[i] = i % 2 ? (float)NAN : (float)INFINITY;
                CHECK_EQUAL(pbw_triangulatef(dim, floats, NULL, 20, NULL, &mesh), PBW_ERROR_NOT_FINITE);
                floats[i] = kept;
            }
            test_end();
        }
    }
    if (test_begin("negative zero is zero, in results too")) {
        static const double zeros[15] = { -0.0, 0, 0, 1, -0.0, 0, 0, 1, -0.0, -0.0, 0, 1, 0, -0.0, -0.0 };
        static const double weights[5] = { -0.0, 0, -0.0, 0, 0 };
        float floats[15], float_weights[5];
        pbw_mesh mesh;
        int way;
        for (i = 0; i < 15; i++) {
            floats[i] = (float)zeros[i];
            float_weights[i / 3] = (float)weights[i / 3];
        }
        for (way = 0; way < 4; way++) {              /* packed points without weights are copied in another way */
            pbw_status status = way < 2
                ? pbw_triangulate(3, zeros, way == 0 ? weights : NULL, 5, NULL, &mesh)
                : pbw_triangulatef(3, floats, way == 2 ? float_weights : NULL, 5, NULL, &mesh);
            CHECK_EQUAL(status, PBW_OK);
            CHECK(mesh.simplex_count == 1 && mesh.duplicate_count == 1 && mesh.canonical[4] == 0);
            for (i = 0; i < 15; i++) {
                CHECK(mesh.points[i] == zeros[i] && !signbit(mesh.points[i]));
            }
            for (i = 0; i < 5 && mesh.weights != NULL; i++) {
                CHECK(mesh.weights[i] == 0 && !signbit(mesh.weights[i]));
            }
            pbw_free(&mesh);
        }
        test_end();
    }
}

/* --- many builds at once --- */

typedef struct job {
    const zoo *animals;
    size_t first, step;
    pbw_mesh *meshes;
    int again;                          /* 1: compare with meshes, 0: fill them */
    long wrong;
} job;

static void *run_job(void *argument)
{
    job *work = (job *)argument;
    size_t i;
    for (i = work->first; i < work->animals->count; i += work->step) {
        const zoo_input *in = work->animals->items + i;
        pbw_options options;
        pbw_mesh mesh;
        memset(&options, 0, sizeof options);
        options.threads = work->again ? (int)(i % 3) : 1;
        meshes_make(in, &options, work->again ? &mesh : work->meshes + i);
        if (work->again) {
            work->wrong += !meshes_equal(&mesh, work->meshes + i);
            work->wrong += pbw_hash(&mesh, NULL) != pbw_hash(work->meshes + i, NULL);
            pbw_free(&mesh);
        }
    }
    return NULL;
}

static void test_reentrancy(void)
{
    if (test_begin("re-entrant: builds, checks and hashes in 6 threads at once")) {
        zoo animals;
        job jobs[7];
        pthread_t threads[7];
        pbw_mesh *meshes;
        size_t i;
        int started[7];
        zoo_fill(&animals);
        meshes = (pbw_mesh *)zoo_grow(NULL, animals.count * sizeof *meshes);
        for (i = 0; i < 7; i++) {
            memset(jobs + i, 0, sizeof jobs[i]);
            jobs[i].animals = &animals;
            jobs[i].meshes = meshes;
            jobs[i].again = i != 6;
            jobs[i].first = i != 6 ? i % 2 : 0;           /* three threads share each half */
            jobs[i].step = i != 6 ? 2 : 1;
        }
        run_job(jobs + 6);
        for (i = 0; i < 6; i++) {
            started[i] = pthread_create(threads + i, NULL, run_job, jobs + i) == 0;
            CHECK(started[i]);
        }
        for (i = 0; i < 6; i++) {
            if (started[i]) {
                pthread_join(threads[i], NULL);
                CHECK_EQUAL(jobs[i].wrong, 0);
            }
        }
        for (i = 0; i < animals.count; i++) {
            pbw_free(meshes + i);
        }
        free(meshes);
        zoo_free(&animals);
        test_end();
    }
}

/* --- the caller's job system --- */

/* The rounding mode of sums: fegetround may tell that of a unit that does none. */
static int rounding(void)
{
    volatile double one = 1, tiny = 1e-30;
    return one + tiny > one ? FE_UPWARD : one - tiny >= one ? FE_TONEAREST
         : -one - tiny < -one ? FE_DOWNWARD : FE_TOWARDZERO;
}

static void run_backwards(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    *(long *)user += tasks;
    for (; tasks > 0; tasks--) {
        task(arg, tasks - 1);
    }
}

typedef struct hired {
    void (*task)(void *arg, int i);
    void *arg;
    int i, wrong;
} hired;

static void *run_hired(void *argument)
{
    hired *one = (hired *)argument;
    int changed = fesetround(FE_UPWARD) == 0;
    one->task(one->arg, one->i);
    one->wrong = changed && rounding() != FE_UPWARD;           /* left as it was */
    return NULL;
}

static void run_one_thread_each(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    pthread_t *threads = (pthread_t *)zoo_grow(NULL, (size_t)tasks * sizeof *threads);
    hired *each = (hired *)zoo_grow(NULL, (size_t)tasks * sizeof *each);
    int i;
    *(long *)user += tasks;
    for (i = 0; i < tasks; i++) {
        each[i].task = task;
        each[i].arg = arg;
        each[i].i = i;
        if (pthread_create(threads + i, NULL, run_hired, each + i) != 0) {
            fprintf(stderr, "no thread\n");
            exit(2);
        }
    }
    for (i = 0; i < tasks; i++) {
        pthread_join(threads[i], NULL);
        CHECK_EQUAL(each[i].wrong, 0);
    }
    free(threads);
    free(each);
}

static void test_run_hook(void)
{
    size_t n = 30000;
    double *points = (double *)zoo_grow(NULL, n * 3 * sizeof *points);
    int dim, way;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("run hook: %dD, tasks backwards on one thread, and each on its own", dim)) {
            pbw_options options;
            pbw_mesh one, other;
            long tasks = 0;
            input_fill(INPUT_UNIFORM, dim, n, test_seed, points);
            memset(&options, 0, sizeof options);
            options.threads = 1;
            CHECK_EQUAL(pbw_triangulate(dim, points, NULL, n, &options, &one), PBW_OK);
            options.threads = 4;
            options.run_user = &tasks;
            for (way = 0; way < 2; way++) {
                options.run = way == 0 ? run_backwards : run_one_thread_each;
                CHECK_EQUAL(pbw_triangulate(dim, points, NULL, n, &options, &other), PBW_OK);
                CHECK(meshes_equal(&one, &other));
                pbw_free(&other);
            }
            pbw_free(&one);
            if (test_verbose) {
                test_say("%ld tasks", tasks);
            }
            test_end();
        }
    }
    free(points);
}

/* Statistics of one thread: what must hold of any build, not how much of it there is. */
static void test_statistics(void)
{
    static const int kinds[2] = { INPUT_UNIFORM, INPUT_LATTICE };
    size_t n = 20000;
    double *points = (double *)zoo_grow(NULL, n * 3 * sizeof *points);
    int dim, k;
    for (dim = 2; dim <= 3; dim++) {
        for (k = 0; k < 2; k++) {
            if (test_begin("statistics: %dD %s", dim, input_name(kinds[k]))) {
                pbw_options options;
                pbw_mesh mesh;
                const pbw_statistics *s = &mesh.statistics;
                memset(&options, 0, sizeof options);
                options.threads = 1;
                input_fill(kinds[k], dim, n, test_seed, points);
                CHECK_EQUAL(pbw_triangulate(dim, points, NULL, n, &options, &mesh), PBW_OK);
                CHECK(s->order_seconds > 0 && s->build_seconds > 0 && s->output_seconds > 0);
                CHECK(s->walk_steps >= n / 2);       /* a walk ends in a simplex; seeds and near ones need none */
                CHECK(s->created > mesh.simplex_count && s->conflict_tests > s->created / 2);
                CHECK(s->exact_tests <= s->conflict_tests && (k == 0 || s->exact_tests > n));
                CHECK(s->threads == 1 && s->postponed == 0 && s->by_backend == 0);
                if (test_verbose) {
                    test_say("%zu walked, %zu tests, %zu exact, %zu created", s->walk_steps, s->conflict_tests,
                             s->exact_tests, s->created);
                }
                pbw_free(&mesh);
                test_end();
            }
        }
    }
    free(points);
}

/* --- the floating-point unit --- */

static void check_in_mode(const zoo *animals, const uint64_t *hashes)
{
    static const double orient[6] = { 0, 0, 1e-200, 0, 0, 1e-200 }, flat[6] = { 0.1, 0.1, 0.2, 0.2, 0.4, 0.4 };
    static const double denormal[6] = { 0, 0, 1e-320, 0, 0, 1e-320 };
    size_t i;
    for (i = 0; i < animals->count; i++) {
        pbw_mesh mesh;
        pbw_report report;
        memset(&report, 0, sizeof report);
        meshes_make(animals->items + i, NULL, &mesh);
        CHECK(pbw_hash(&mesh, NULL) == hashes[i]);
        CHECK(mesh.point_count == 0 || (pbw_check(&mesh, NULL, &report) == PBW_OK && report.valid));
        pbw_free(&mesh);
    }
    CHECK_EQUAL(pbw_orient2(orient, orient + 2, orient + 4), 1);             /* products underflow */
    CHECK_EQUAL(pbw_orient2(flat, flat + 2, flat + 4), 0);
    CHECK_EQUAL(pbw_orient2(denormal, denormal + 2, denormal + 4), 1);
}

static void test_modes(void)
{
    static const int modes[4] = { FE_TONEAREST, FE_DOWNWARD, FE_UPWARD, FE_TOWARDZERO };
    static const char *const names[4] = { "to nearest", "downward", "upward", "toward zero" };
    zoo animals;
    uint64_t *hashes;
    size_t i;
    int k;
    zoo_fill(&animals);
    hashes = (uint64_t *)zoo_grow(NULL, animals.count * sizeof *hashes);
    for (i = 0; i < animals.count; i++) {
        pbw_mesh mesh;
        if (animals.items[i].count > 130) {               /* the small ones are enough */
            animals.items[i].count = 130;
        }
        meshes_make(animals.items + i, NULL, &mesh);
        hashes[i] = pbw_hash(&mesh, NULL);
        pbw_free(&mesh);
    }
    for (k = 0; k < 4; k++) {
        if (test_begin("rounding %s: right, and left as it was", names[k])) {
            if (fesetround(modes[k]) != 0) {
                test_skip("not a rounding mode of this machine");
                continue;
            }
            check_in_mode(&animals, hashes);
            CHECK_EQUAL(rounding(), modes[k]);
            fesetround(FE_TONEAREST);
            test_end();
        }
    }
#if defined(__SSE2__)
    if (test_begin("denormals flushed and read as zero: right, and left as it was")) {
        unsigned state = _mm_getcsr();
        _mm_setcsr(state | 0x8040u);
        if ((_mm_getcsr() & 0x8040u) == 0x8040u) {
            check_in_mode(&animals, hashes);
            CHECK_EQUAL(_mm_getcsr() & 0xffc0u, (state | 0x8040u) & 0xffc0u);
            _mm_setcsr(state);
            test_end();
        } else {
            test_skip("this machine, or valgrind, has no such mode");
        }
    }
    if (test_begin("traps on overflow, invalid and division by zero: none is raised")) {
        unsigned state = _mm_getcsr();
        _mm_setcsr(state & ~0x0680u & ~0x3fu);
        check_in_mode(&animals, hashes);
        _mm_setcsr(state);
        test_end();
    }
#endif
    free(hashes);
    zoo_free(&animals);
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 0);
    test_arguments();
    test_backends();
    test_backend_job();
    test_reads();
    test_small();
    test_reentrancy();
    test_run_hook();
    test_statistics();
    test_modes();
    return test_finish();
}
