/* test_tools.c: what companion headers build on: pbw_for, pbw_order, pbw_conflict2 and 3, the partial hash, memory,
   arrays, sorting, exact sums, centres, and the flags PBW_CURVE_ORDER and PBW_BORROW. */
#include "pbw_check.h"
#include <float.h>
#include <math.h>
#include "meshes.h"
#include "meter.h"
#include "test.h"
#include "watch.h"

/* --- pbw_for --- */

typedef struct visits {
    unsigned char *seen;
    size_t count, grain;
    size_t fails[2];                                 /* the ranges that fail; all ones: none */
    int wrong;
} visits;

static pbw_status visit(void *arg, size_t from, size_t to)
{
    visits *v = (visits *)arg;
    size_t i;
    if (from % v->grain != 0 || from >= to || (to != from + v->grain && to != v->count)) {
        __atomic_store_n(&v->wrong, 1, __ATOMIC_RELAXED);
    }
    for (i = from; i < to; i++) {
        v->seen[i]++;                                /* a byte that two threads visit is a race: ThreadSanitizer */
    }
    return from / v->grain == v->fails[0] ? PBW_ERROR_BACKEND
         : from / v->grain == v->fails[1] ? PBW_ERROR_MEMORY : PBW_OK;
}

static void run_backwards(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    *(int *)user += 1;
    while (tasks > 0) {
        task(arg, --tasks);
    }
}

static int times_seen(const visits *v, int times)
{
    size_t i;
    for (i = 0; i < v->count && v->seen[i] == times; i++) {
    }
    return i == v->count;
}

static void test_for(void)
{
    static const size_t counts[] = { 0, 1, 7, 64, 1000, 100001 };
    static unsigned char seen[100001];
    size_t i, grain;
    int threads;
    for (threads = 1; threads <= 9; threads += 4) {
        for (i = 0; i < sizeof counts / sizeof *counts && test_begin("ranges of %d on %d threads", (int)counts[i],
                                                                    threads); i++) {
            for (grain = 1; grain <= 4096; grain *= 16) {
                pbw_options options;
                visits v = { seen, 0, 0, { (size_t)-1, (size_t)-1 }, 0 };
                watch w;
                int runs = 0;
                memset(&options, 0, sizeof options);
                memset(seen, 0, sizeof seen);
                watch_start(&w, 0);
                v.count = counts[i];
                v.grain = grain;
                options.threads = threads;
                options.progress = watch_progress;
                options.progress_user = &w;
                CHECK_EQUAL(pbw_for(&options, v.count, grain, visit, &v), PBW_OK);
                CHECK(times_seen(&v, 1) && !v.wrong);
                CHECK_EQUAL(w.wrong, 0);
                CHECK(w.stages == 1 << PBW_STAGE_WORK && w.done == 1);
                options.run = run_backwards;
                options.run_user = &runs;
                CHECK_EQUAL(pbw_for(&options, v.count, grain, visit, &v), PBW_OK);
                CHECK(times_seen(&v, 2) && !v.wrong);
                CHECK_EQUAL(runs, threads > 1 && v.count > grain);
            }
            test_end();
        }
    }
    for (threads = 1; threads <= 16 && test_begin("the lowest range that fails, %d threads", threads); threads *= 2) {
        pbw_options options;
        int repeat;
        memset(&options, 0, sizeof options);
        options.threads = threads;
        for (repeat = 0; repeat < 20; repeat++) {
            visits v = { seen, sizeof seen, 100, { 400, 407 }, 0 };
            size_t finished = 0;
            memset(seen, 0, sizeof seen);
            CHECK_EQUAL(pbw_for(&options, v.count, 100, visit, &v), PBW_ERROR_BACKEND);
            while (finished < v.count && seen[finished] == 1) {
                finished++;
            }
            CHECK(finished >= 40100);                /* all below it were finished */
            CHECK(seen[v.count - 1] == 0);
            v.fails[1] = 3;
            CHECK_EQUAL(pbw_for(&options, v.count, 100, visit, &v), PBW_ERROR_MEMORY);
        }
        test_end();
    }
    if (test_begin("ranges: refusals")) {
        visits v = { seen, sizeof seen, 10, { (size_t)-1, (size_t)-1 }, 0 };
        pbw_options options;
        meter m;
        watch w;
        memset(&options, 0, sizeof options);
        CHECK_EQUAL(pbw_for(NULL, 10, 0, visit, &v), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_for(NULL, 10, 1, NULL, &v), PBW_ERROR_ARGUMENT);
        options.threads = -1;
        CHECK_EQUAL(pbw_for(&options, 10, 1, visit, &v), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_for(NULL, (size_t)-1, 1, visit, &v), PBW_ERROR_TOO_LARGE);
        options.threads = 4;
        meter_start(&m, 1, 1);                       /* no memory for a team: the caller's thread does it */
        options.resize = meter_resize;
        options.resize_user = &m;
        memset(seen, 0, sizeof seen);
        CHECK_EQUAL(pbw_for(&options, v.count, 10, visit, &v), PBW_OK);
        CHECK(times_seen(&v, 1) && m.blocks == 0 && m.refused > 0);
        watch_start(&w, 2);
        options.progress = watch_progress;
        options.progress_user = &w;
        CHECK_EQUAL(pbw_for(&options, v.count, 10, visit, &v), PBW_CANCELLED);
        test_end();
    }
}

/* --- pbw_order and PBW_CURVE_ORDER --- */

static int is_permutation(const pbw_index *order, size_t count)
{
    unsigned char *seen = (unsigned char *)calloc(count + 1, 1);
    size_t i;
    int right = 1;
    for (i = 0; i < count; i++) {
        right = right && order[i] < count && !seen[order[i]]++;
    }
    free(seen);
    return right;
}

/* Is the mesh, of the flag PBW_CURVE_ORDER, `plain` with other numbers? */
static void check_renumbered(const pbw_mesh *mesh, const pbw_mesh *plain)
{
    const size_t dim = (size_t)plain->dim, corners = dim + 1, count = plain->point_count;
    pbw_index *number = (pbw_index *)malloc((count + 1) * sizeof *number);
    size_t i, wrong = 0;
    CHECK(mesh->point_count == count && mesh->simplex_count == plain->simplex_count);
    CHECK(mesh->duplicate_count == plain->duplicate_count && mesh->hidden_count == plain->hidden_count);
    CHECK(count == 0 || (mesh->original != NULL && is_permutation(mesh->original, count)));
    CHECK(plain->original == NULL);
    for (i = 0; i < count; i++) {
        number[mesh->original[i]] = (pbw_index)i;
    }
    for (i = 0; i < plain->simplex_count * corners; i++) {
        wrong += mesh->simplices[i] != number[plain->simplices[i]];
        wrong += mesh->neighbors[i] != plain->neighbors[i];
    }
    for (i = 0; i < count; i++) {
        const size_t old = mesh->original[i];
        wrong += mesh->incident[i] != plain->incident[old];
        wrong += mesh->canonical[i] != number[plain->canonical[old]];
        wrong += memcmp(mesh->points + i * dim, plain->points + old * dim, dim * sizeof(double)) != 0;
        wrong += plain->weights != NULL && memcmp(mesh->weights + i, plain->weights + old, sizeof(double)) != 0;
    }
    CHECK_EQUAL(wrong, 0);
    free(number);
}

static void check_curve_order(const zoo_input *in)
{
    pbw_mesh plain, mesh, again;
    pbw_options options;
    pbw_status status = meshes_make(in, NULL, &plain);
    pbw_index *order = (pbw_index *)malloc((in->count + 1) * sizeof *order);
    size_t i;
    memset(&options, 0, sizeof options);
    options.flags = PBW_CURVE_ORDER;
    CHECK_EQUAL(meshes_make(in, &options, &mesh), status);
    if (status == PBW_OK || status == PBW_DEGENERATE) {
        check_renumbered(&mesh, &plain);
        CHECK(meshes_fault(&mesh) == NULL);
        CHECK(pbw_hash(&mesh, NULL) == pbw_hash(&plain, NULL));
        options.threads = 3;
        CHECK_EQUAL(meshes_make(in, &options, &again), status);
        CHECK(meshes_equal(&mesh, &again));
        CHECK(in->count == 0 || memcmp(mesh.original, again.original, in->count * sizeof *order) == 0);
        for (i = 1; i < in->count; i++) {            /* simplices begin at ascending vertices */
            CHECK(i >= mesh.simplex_count
                  || mesh.simplices[i * ((size_t)in->dim + 1)] >= mesh.simplices[(i - 1) * ((size_t)in->dim + 1)]);
        }
        if (in->weights == NULL) {
            CHECK_EQUAL(pbw_order(in->dim, in->points, in->count, NULL, order), PBW_OK);
            CHECK(in->count == 0 || memcmp(order, mesh.original, in->count * sizeof *order) == 0);
        }
        pbw_free(&mesh);
        pbw_free(&again);
        pbw_free(&plain);
    } else {
        CHECK(in->weights != NULL || pbw_order(in->dim, in->points, in->count, NULL, order) == status);
    }
    free(order);
}

static void fail_each(int dim, const double *points, size_t count, unsigned flags)
{
    pbw_index *order = (pbw_index *)malloc(count * sizeof *order);
    long k;
    int refused = 1;
    for (k = 1; refused; k++) {
        pbw_options options;
        pbw_mesh mesh;
        meter m;
        pbw_status status;
        memset(&options, 0, sizeof options);
        options.resize = meter_resize;
        options.resize_user = &m;
        options.threads = 1;
        meter_start(&m, k, 0);
        status = pbw_order(dim, points, count, &options, order);
        CHECK(status == (m.refused ? PBW_ERROR_MEMORY : PBW_OK));
        CHECK(m.blocks == 0 && m.faults == 0);
        refused = m.refused > 0;
        meter_start(&m, k, 0);
        options.flags = flags;
        status = pbw_triangulate(dim, points, NULL, count, &options, &mesh);
        CHECK(status == PBW_OK || (m.refused && status == PBW_ERROR_MEMORY));
        refused |= m.refused > 0;
        pbw_free(&mesh);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    free(order);
}

/* A backend that lets the CPU do the work: its arrays must be numbered along the curve all the same. */
static pbw_status forward(const pbw_backend *backend, pbw_job *job)
{
    pbw_mesh mesh;
    pbw_status status = pbw_triangulate(job->dim, (const double *)job->points, (const double *)job->weights,
                                        job->count, NULL, &mesh);
    size_t links = mesh.simplex_count * ((size_t)job->dim + 1) * sizeof(pbw_index);
    (void)backend;
    if (status != PBW_OK) {
        return status;
    }
    status = job->reserve(job, mesh.simplex_count);
    if (status == PBW_OK) {
        memcpy(job->simplices, mesh.simplices, links);
        memcpy(job->neighbors, mesh.neighbors, links);
        memcpy(job->incident, mesh.incident, job->count * sizeof(pbw_index));
        memcpy(job->canonical, mesh.canonical, job->count * sizeof(pbw_index));
        job->duplicate_count = mesh.duplicate_count;
        job->hidden_count = mesh.hidden_count;
    }
    pbw_free(&mesh);
    return status;
}

static void test_backend(void)
{
    int dim, weighted;
    for (dim = 2; dim <= 3; dim++) {
        for (weighted = 0; weighted < 2 && test_begin("a backend in curve order, %dD, weights %d", dim, weighted);
             weighted++) {
            static double points[3 * 3000], weights[3000];
            pbw_backend backend = { PBW_VERSION, forward, NULL };
            pbw_options options;
            pbw_mesh here, there;
            meter m;
            long k;
            memset(&options, 0, sizeof options);
            input_fill(INPUT_CLUSTERS, dim, 3000, 5, points);
            memcpy(points + 300, points, 60 * sizeof(double));
            input_fill_weights(INPUT_WEIGHTS_HALF, dim, 3000, 5, points, weights);
            options.flags = PBW_CURVE_ORDER;
            CHECK_EQUAL(pbw_triangulate(dim, points, weighted ? weights : NULL, 3000, &options, &here), PBW_OK);
            options.backend = &backend;
            options.resize = meter_resize;
            options.resize_user = &m;
            for (k = 1; k == 1 || m.refused > 0; k++) {
                meter_start(&m, k, 0);
                if (pbw_triangulate(dim, points, weighted ? weights : NULL, 3000, &options, &there) == PBW_OK) {
                    CHECK(meshes_equal(&here, &there));
                    CHECK(memcmp(here.original, there.original, 3000 * sizeof(pbw_index)) == 0);
                    CHECK_EQUAL(there.statistics.by_backend, 1);
                } else {
                    CHECK(m.refused > 0);
                }
                pbw_free(&there);
                CHECK(m.blocks == 0 && m.faults == 0);
            }
            pbw_free(&here);
            test_end();
        }
    }
}

static void test_order(void)
{
    zoo animals;
    size_t i;
    zoo_fill(&animals);
    for (i = 0; i < animals.count; i++) {
        if (animals.items[i].count <= 3000 && test_begin("curve order: %s", animals.items[i].name)) {
            check_curve_order(&animals.items[i]);
            test_end();
        }
    }
    zoo_free(&animals);
    if (test_begin("pbw_order: options and failures")) {
        static double points[3 * 2000];
        static pbw_index order[2000], other[1000];
        pbw_options options;
        memset(&options, 0, sizeof options);
        input_fill(INPUT_UNIFORM, 3, 2000, 5, points);
        memcpy(points + 30, points, 12 * sizeof(double));                    /* duplicates */
        CHECK_EQUAL(pbw_order(3, points, 2000, NULL, order), PBW_OK);
        options.stride = 6 * sizeof(double);
        CHECK_EQUAL(pbw_order(3, points, 1000, &options, other), PBW_OK);
        CHECK(is_permutation(order, 2000) && is_permutation(other, 1000));
        CHECK_EQUAL(pbw_order(4, points, 10, NULL, order), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_order(3, points, 10, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_order(3, NULL, 10, NULL, order), PBW_ERROR_ARGUMENT);
        fail_each(3, points, 2000, PBW_CURVE_ORDER);
        points[4] = HUGE_VAL;
        CHECK_EQUAL(pbw_order(3, points, 10, NULL, order), PBW_ERROR_NOT_FINITE);
        test_end();
    }
    if (test_begin("the order follows a curve")) {
        static double points[3 * 20000];
        static pbw_index order[20000];
        double along = 0, across = 0;
        int k;
        input_fill(INPUT_UNIFORM, 3, 20000, 7, points);
        CHECK_EQUAL(pbw_order(3, points, 20000, NULL, order), PBW_OK);
        for (i = 1; i < 20000; i++) {
            for (k = 0; k < 3; k++) {
                along += fabs(points[3 * order[i] + (size_t)k] - points[3 * order[i - 1] + (size_t)k]);
                across += fabs(points[3 * i + (size_t)k] - points[3 * (i - 1) + (size_t)k]);
            }
        }
        CHECK(along < 0.08 * across);                /* about 20000^(-1/3) of it */
        test_end();
    }
}

/* --- PBW_BORROW --- */

static void test_borrow(void)
{
    int dim, weighted;
    for (dim = 2; dim <= 3; dim++) {
        for (weighted = 0; weighted < 2 && test_begin("borrowed points, %dD, weights %d", dim, weighted);
             weighted++) {
            static double points[3 * 1000], weights[1000], kept[3 * 1000];
            static float single[3 * 1000];
            pbw_options options;
            pbw_mesh mesh, plain;
            meter m;
            memset(&options, 0, sizeof options);
            memset(points, 0, sizeof points);
            input_fill(INPUT_LATTICE, dim, 1000, 3, points);
            input_fill_weights(INPUT_WEIGHTS_HALF, dim, 1000, 3, points, weights);
            points[0] = -0.0;
            memcpy(kept, points, sizeof kept);
            meter_start(&m, 0, 0);
            CHECK_EQUAL(pbw_triangulate(dim, points, weighted ? weights : NULL, 1000, &options, &plain), PBW_OK);
            options.flags = PBW_BORROW;
            options.resize = meter_resize;
            options.resize_user = &m;
            CHECK_EQUAL(pbw_triangulate(dim, points, weighted ? weights : NULL, 1000, &options, &mesh), PBW_OK);
            CHECK(mesh.points == points && mesh.weights == (weighted ? weights : NULL));
            CHECK(meshes_fault(&mesh) == NULL && pbw_hash(&mesh, NULL) == pbw_hash(&plain, NULL));
            CHECK_EQUAL(memcmp(mesh.simplices, plain.simplices,
                               plain.simplex_count * ((size_t)dim + 1) * sizeof(pbw_index)), 0);
            CHECK(m.bytes <= (plain.simplex_count * 2 * ((size_t)dim + 1) + 2 * 1000) * sizeof(pbw_index) + 4096);
            pbw_free(&mesh);
            CHECK(m.blocks == 0 && m.faults == 0 && memcmp(points, kept, sizeof kept) == 0);
            options.stride = 4 * sizeof(double);
            CHECK_EQUAL(pbw_triangulate(dim, points, NULL, 100, &options, &mesh), PBW_ERROR_ARGUMENT);
            options.stride = 0;
            options.flags |= PBW_CURVE_ORDER;
            CHECK_EQUAL(pbw_triangulate(dim, points, NULL, 100, &options, &mesh), PBW_ERROR_ARGUMENT);
            options.flags = PBW_BORROW;
            CHECK_EQUAL(pbw_triangulatef(dim, single, NULL, 100, &options, &mesh), PBW_ERROR_ARGUMENT);
            if (weighted) {
                options.weight_stride = 16;
                CHECK_EQUAL(pbw_triangulate(dim, points, weights, 100, &options, &mesh), PBW_ERROR_ARGUMENT);
            }
            options.weight_stride = 0;
            memset(points, 0, sizeof points);        /* no simplices: borrowed all the same */
            CHECK_EQUAL(pbw_triangulate(dim, points, NULL, 100, &options, &mesh), PBW_DEGENERATE);
            CHECK(mesh.points == points && meshes_fault(&mesh) == NULL);
            pbw_free(&mesh);
            CHECK(m.blocks == 0 && m.faults == 0);
            pbw_free(&plain);
            test_end();
        }
    }
}

/* --- conflicts --- */

static int conflict_of(const pbw_mesh *mesh, size_t simplex, size_t point)
{
    const size_t dim = (size_t)mesh->dim;
    const pbw_index *corner = mesh->simplices + simplex * (dim + 1);
    const double *x[5];
    double w[5];
    size_t i;
    for (i = 0; i <= dim + 1; i++) {
        const size_t p = i <= dim ? corner[i] : point;
        x[i] = mesh->points + p * dim;
        w[i] = mesh->weights != NULL ? mesh->weights[p] : 0;
    }
    return dim == 2 ? pbw_conflict2(x[0], x[1], x[2], x[3], mesh->weights != NULL ? w : NULL)
                    : pbw_conflict3(x[0], x[1], x[2], x[3], x[4], mesh->weights != NULL ? w : NULL);
}

/* The simplices of a triangulation are those positive ones with which no point is in conflict: tried are all. */
static void check_conflicts(const zoo_input *in)
{
    const size_t corners = (size_t)in->dim + 1;
    pbw_mesh mesh;
    size_t s, p, k;
    if (meshes_make(in, NULL, &mesh) == PBW_OK) {
        for (s = 0; s < mesh.simplex_count; s++) {
            for (p = 0; p < mesh.point_count; p++) {
                int corner = mesh.canonical[p] != p;
                for (k = 0; k < corners; k++) {
                    corner |= mesh.simplices[s * corners + k] == p;
                }
                CHECK(corner || !conflict_of(&mesh, s, p));
            }
        }
        for (s = 0; s < mesh.simplex_count; s++) {   /* flipped away: each simplex that a neighbour's corner spoils */
            for (k = 0; k < corners; k++) {
                const pbw_index *v = mesh.simplices + s * corners, n = mesh.neighbors[s * corners + k];
                const double *x[5], w[5] = { 0, 0, 0, 0, 0 };
                size_t i, far_corner = 0;
                if (n == PBW_NONE || mesh.weights != NULL) {
                    continue;
                }
                for (i = 0; i < corners; i++) {
                    far_corner = mesh.neighbors[n * corners + i] == s ? i : far_corner;
                }
                for (i = 0; i < corners; i++) {      /* corner k replaced by the far one, then k is the test point */
                    x[i] = mesh.points + (size_t)in->dim * (i == k ? mesh.simplices[n * corners + far_corner] : v[i]);
                }
                x[corners] = mesh.points + (size_t)in->dim * v[k];
                if (in->dim == 3 && pbw_orient3(x[0], x[1], x[2], x[3]) > 0) {
                    CHECK(pbw_insphere(x[0], x[1], x[2], x[3], x[4]) >= 0
                          || !pbw_conflict3(x[0], x[1], x[2], x[3], x[4], w));
                    CHECK(pbw_insphere(x[0], x[1], x[2], x[3], x[4]) <= 0
                          || pbw_conflict3(x[0], x[1], x[2], x[3], x[4], NULL));
                }
            }
        }
    }
    pbw_free(&mesh);                                 /* degenerate ones hold arrays, too */
}

static void test_conflicts(void)
{
    zoo animals;
    size_t i;
    zoo_fill(&animals);
    for (i = 0; i < animals.count; i++) {
        if (animals.items[i].count <= 150 && animals.items[i].finite
            && test_begin("conflicts: %s", animals.items[i].name)) {
            check_conflicts(&animals.items[i]);
            test_end();
        }
    }
    zoo_free(&animals);
    if (test_begin("the diagonal of a square follows the tie rule")) {
        const double a[2] = { 0, 0 }, b[2] = { 1, 0 }, c[2] = { 1, 1 }, d[2] = { 0, 1 };
        const double w[4] = { 0, 0, 0, 1 }, light[4] = { 0, 0, 0, -1 };
        CHECK(pbw_conflict2(a, b, c, d, NULL) != pbw_conflict2(b, c, d, a, NULL));   /* one diagonal or the other */
        CHECK_EQUAL(pbw_conflict2(a, b, c, d, NULL), pbw_conflict2(c, d, a, b, NULL));
        CHECK_EQUAL(pbw_conflict2(a, b, c, d, w), 1);
        CHECK_EQUAL(pbw_conflict2(a, b, c, d, light), 0);
        test_end();
    }
}

/* --- hashes --- */

static void test_hashes(void)
{
    int dim;
    for (dim = 2; dim <= 3 && test_begin("hash in parts, %dD", dim); dim++) {
        static double points[3 * 40000], weights[40000];
        pbw_mesh mesh;
        pbw_options options;
        pbw_hash_sums sums = { 0, 0 }, part;
        unsigned char *point, *simplex;
        size_t i;
        int k, cancelled = 1;
        watch w;
        memset(&options, 0, sizeof options);
        input_fill(INPUT_UNIFORM, dim, 40000, 11, points);
        memcpy(points, points + 300, 60 * sizeof(double));
        input_fill_weights(INPUT_WEIGHTS_HALF, dim, 40000, 11, points, weights);
        CHECK_EQUAL(pbw_triangulate(dim, points, weights, 40000, NULL, &mesh), PBW_OK);
        point = (unsigned char *)malloc(mesh.point_count);
        simplex = (unsigned char *)malloc(mesh.simplex_count);
        for (k = 0; k < 3; k++) {
            for (i = 0; i < mesh.point_count; i++) {
                point[i] = i * 2654435761u % 3 == (size_t)k;
            }
            for (i = 0; i < mesh.simplex_count; i++) {
                simplex[i] = i * 40503u % 3 == (size_t)k;
            }
            options.threads = 1 + k;
            CHECK_EQUAL(pbw_hash_parts(&mesh, point, simplex, &options, &part), PBW_OK);
            CHECK(pbw_hash_of(&part) != pbw_hash(&mesh, NULL));
            sums.points += part.points;
            sums.simplices += part.simplices;
        }
        CHECK(pbw_hash_of(&sums) == pbw_hash(&mesh, NULL) && pbw_hash_of(&sums) != 0);
        CHECK_EQUAL(pbw_hash_parts(&mesh, NULL, NULL, NULL, &part), PBW_OK);
        CHECK(part.points == sums.points && part.simplices == sums.simplices);
        CHECK_EQUAL(pbw_hash_parts(NULL, NULL, NULL, NULL, &part), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_hash_parts(&mesh, NULL, NULL, NULL, NULL), PBW_ERROR_ARGUMENT);
        watch_start(&w, cancelled);
        options.progress = watch_progress;
        options.progress_user = &w;
        CHECK_EQUAL(pbw_hash_parts(&mesh, NULL, NULL, &options, &part), PBW_CANCELLED);
        watch_start(&w, cancelled);
        CHECK(pbw_hash(&mesh, &options) == 0);
        free(point);
        free(simplex);
        pbw_free(&mesh);
        test_end();
    }
}

/* --- memory and arrays --- */

typedef struct crowd {
    pbw_memory memory;
    size_t served, refused, most;
} crowd;

/* Grows an array through the memory of all threads, until the limit refuses it or it has enough, and frees it. */
static pbw_status take_and_give(void *arg, size_t from, size_t to)
{
    crowd *c = (crowd *)arg;
    PBW_ARRAY(uint32_t) list = { NULL, 0, 0 };
    pbw_status status = PBW_OK;
    uint32_t i, many = (uint32_t)(1000 + from * 7919 % 5000);
    (void)to;
    for (i = 0; i < many && PBW_PUSH(&c->memory, list, i); i++) {
    }
    (void)PBW_ATOMIC_ADD(i == many ? &c->served : &c->refused, 1);
    pbw_atomic_max(&c->most, list.capacity);
    while (i > 0) {
        i--;
        status = list.at[i] == i ? status : PBW_ERROR_BACKEND;
    }
    PBW_RELEASE(&c->memory, list);
    return list.at == NULL && list.count == 0 && list.capacity == 0 ? status : PBW_ERROR_BACKEND;
}

static void test_limit_of_many(void)
{
    int threads;
    for (threads = 1; threads <= 8 && test_begin("memory of %d threads, limited", threads); threads *= 2) {
        pbw_options options;
        crowd c;
        meter m;
        memset(&options, 0, sizeof options);
        memset(&c, 0, sizeof c);
        meter_start(&m, 0, 0);
        options.resize = meter_resize;
        options.resize_user = &m;
        options.memory_limit = 30000;
        pbw_memory_start(&c.memory, &options);
        options.memory_limit = 0;
        options.resize = NULL;
        options.threads = threads;
        CHECK_EQUAL(pbw_for(&options, 4000, 1, take_and_give, &c), PBW_OK);
        CHECK_EQUAL(c.served + c.refused, 4000);
        CHECK(c.served > 0 && (threads > 1 || c.refused == 0) && c.most >= 1000 && c.most < 9000);
        CHECK(m.peak <= 30000 && c.memory.peak <= 30000 && c.memory.peak >= 4 * c.most);
        CHECK(c.memory.used == 0 && m.bytes == 0 && m.blocks == 0 && m.faults == 0);
        test_end();
    }
}

/* What the calls below allocate, in one order; returns 0 if memory was short, and then frees all. */
typedef struct pair_of_lists {
    PBW_ARRAY(double) x;
    PBW_ARRAY(pbw_pair) y;
} pair_of_lists;

static int fill_lists(pbw_memory *memory, pair_of_lists *lists)
{
    pbw_pair item = { 1, 2 };
    size_t i;
    int ok = PBW_ZEROS(memory, lists->x, 100);
    for (i = 0; ok && i < 200; i++) {
        item.head = (double)i;
        ok = PBW_PUSH(memory, lists->x, (double)i) && PBW_PUSH(memory, lists->y, item);
    }
    ok = ok && PBW_RESERVE(memory, lists->y, 5000) && PBW_FIT(memory, lists->y, lists->y.count);
    for (i = 0; i < lists->x.count; i++) {           /* whatever failed, what was there is there */
        CHECK(lists->x.at[i] == (i < 100 ? 0 : (double)(i - 100)));
    }
    for (i = 0; i < lists->y.count; i++) {
        CHECK(lists->y.at[i].head == (double)i && lists->y.at[i].tail == 2);
    }
    CHECK(!ok || (lists->x.count == 300 && lists->y.count == 200 && lists->y.capacity == 200));
    return ok;
}

static void test_arrays(void)
{
    pbw_options options;
    pbw_memory memory;
    pair_of_lists lists;
    meter m;
    long k;
    memset(&options, 0, sizeof options);
    memset(&lists, 0, sizeof lists);
    options.resize = meter_resize;
    options.resize_user = &m;
    for (k = 0; test_begin("arrays; request %ld fails", k); k++) {
        int ok;
        meter_start(&m, k, k % 2 == 1);
        pbw_memory_start(&memory, &options);
        ok = fill_lists(&memory, &lists);
        CHECK(memory.used == m.bytes && memory.peak == m.peak && ok == (m.refused == 0));
        CHECK_EQUAL(memory.used, lists.x.capacity * sizeof(double) + lists.y.capacity * sizeof(pbw_pair));
        PBW_RELEASE(&memory, lists.x);
        PBW_RELEASE(&memory, lists.y);
        PBW_RELEASE(&memory, lists.y);
        CHECK(memory.used == 0 && m.blocks == 0 && m.faults == 0);
        test_end();
        if (k > 0 && m.refused == 0) {
            CHECK(ok && k > 5);                      /* of each k-th request that there is */
            break;
        }
    }
    if (test_begin("sizes that overflow")) {
        const size_t most = (size_t)-1, before = 3;
        void *block;
        meter_start(&m, 0, 0);
        pbw_memory_start(&memory, &options);
        CHECK(PBW_ZEROS(&memory, lists.x, before) && lists.x.capacity == before);
        CHECK(!PBW_RESERVE(&memory, lists.x, most) && !PBW_RESERVE(&memory, lists.x, most - 2));
        CHECK(!PBW_RESERVE(&memory, lists.x, most / sizeof(double)) && !PBW_FIT(&memory, lists.x, most / 8 + 2));
        CHECK(!PBW_ZEROS(&memory, lists.y, most / 16 + 2) && lists.y.at == NULL && lists.y.count == 0);
        CHECK(pbw_memory_resize(&memory, NULL, 0, most / 16 + 2, 16) == NULL);
        CHECK(lists.x.capacity == before && lists.x.at[2] == 0 && memory.used == 24 && m.requests == 1);
        PBW_RELEASE(&memory, lists.x);
        CHECK(PBW_ZEROS(&memory, lists.x, 0) && lists.x.at != NULL && lists.x.count == 0);
        PBW_RELEASE(&memory, lists.x);
        block = pbw_memory_resize(&memory, NULL, 0, 10, 7);
        CHECK(block != NULL && memory.used == 70);
        block = pbw_memory_resize(&memory, block, 10, 20, 7);
        CHECK(block != NULL && memory.used == 140 && memory.peak == 140);
        CHECK(pbw_memory_resize(&memory, block, 20, 0, 7) == NULL && memory.used == 0 && m.blocks == 0);
        CHECK(pbw_memory_resize(&memory, NULL, 0, 0, 7) == NULL && m.faults == 0);       /* nothing to do */
        pbw_memory_start(&memory, NULL);
        block = pbw_memory_resize(&memory, NULL, 0, (size_t)5 << 20, 1);         /* with huge pages */
        CHECK(block != NULL && memory.limit == 0 && pbw_memory_left(&memory) == 0);
        (void)pbw_memory_resize(&memory, block, (size_t)5 << 20, 0, 1);
        test_end();
    }
}

static void test_nested(void)
{
    static double points[3 * 2000];
    pbw_options options, inner;
    pbw_memory memory;
    pbw_mesh mesh;
    meter m;
    input_fill(INPUT_UNIFORM, 3, 2000, 5, points);
    if (test_begin("calls within calls")) {
        size_t needed;
        void *held;
        memset(&options, 0, sizeof options);
        meter_start(&m, 0, 0);
        options.resize = meter_resize;
        options.resize_user = &m;
        options.threads = 1;
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, 2000, &options, &mesh), PBW_OK);
        needed = mesh.statistics.peak_bytes;
        pbw_free(&mesh);
        for (options.memory_limit = needed + 999; options.memory_limit <= needed + 1000; options.memory_limit++) {
            inner = options;
            meter_start(&m, 0, 0);
            pbw_memory_start(&memory, &options);
            held = pbw_memory_resize(&memory, NULL, 0, 1000, 1);
            CHECK_EQUAL(pbw_memory_left(&memory), options.memory_limit - 1000);
            pbw_memory_nest(&memory, &inner);
            CHECK_EQUAL(inner.memory_limit, 0);
            CHECK_EQUAL(pbw_triangulate(3, points, NULL, 2000, &inner, &mesh),
                        options.memory_limit == needed + 1000 ? PBW_OK : PBW_ERROR_MEMORY);
            CHECK(m.peak <= options.memory_limit && memory.peak == m.peak);
            CHECK(memory.used == m.bytes && (mesh.simplex_count == 0) == (m.bytes == 1000));
            pbw_free(&mesh);
            CHECK_EQUAL(memory.used, 1000);
            (void)pbw_memory_resize(&memory, held, 1000, 0, 1);
            CHECK(memory.used == 0 && m.blocks == 0 && m.faults == 0);
        }
        options.memory_limit = 10;
        pbw_memory_start(&memory, &options);
        held = pbw_memory_resize(&memory, NULL, 0, 10, 1);
        CHECK_EQUAL(pbw_memory_left(&memory), 1);
        (void)pbw_memory_resize(&memory, held, 10, 0, 1);
        options.memory_limit = 0;                    /* none: nothing is counted, and the allocator is handed on */
        pbw_memory_start(&memory, &options);
        memset(&inner, 0, sizeof inner);
        pbw_memory_nest(&memory, &inner);
        CHECK(inner.resize == meter_resize && inner.resize_user == &m && inner.memory_limit == 0);
        pbw_memory_start(&memory, NULL);
        pbw_memory_nest(&memory, &inner);
        CHECK(inner.resize == NULL);
        test_end();
    }
}

/* --- sorting --- */

typedef struct keyed { uint64_t key; pbw_index index; } keyed;

static int compare_keyed(const void *a, const void *b)
{
    const keyed *x = (const keyed *)a, *y = (const keyed *)b;
    return x->key != y->key ? (x->key > y->key) - (x->key < y->key) : (x->index > y->index) - (x->index < y->index);
}

static int ascends(const uint64_t *keys, const pbw_index *order, size_t count)
{
    size_t i;
    for (i = 1; i < count && keys[order[i - 1]] <= keys[order[i]]; i++) {
    }
    return i == count;
}

static void test_sort(void)
{
    static const size_t counts[] = { 0, 1, 2, 63, 64, 65, 1000, 200000 };
    static uint64_t keys[200000];
    static keyed expected[200000];
    static pbw_index order[200001];
    static const char *const kinds[] = { "of 64 bits", "equal", "with equal high halves", "with equal low halves", "few",
                                         "descending" };
    pbw_options options;
    size_t c, i;
    int kind;
    memset(&options, 0, sizeof options);
    for (kind = 0; kind < 6 && test_begin("keys %s, sorted", kinds[kind]); kind++) {
        for (c = 0; c < sizeof counts / sizeof *counts; c++) {
            for (i = 0; i < counts[c]; i++) {
                const uint64_t r = pbw_random(7, i);
                keys[i] = kind == 0 ? r : kind == 1 ? 42 : kind == 2 ? (UINT64_C(77) << 32) + (r >> 32)
                        : kind == 3 ? r >> 32 << 32 : kind == 4 ? r % 5 * UINT64_C(0x3000000070000000)
                        : UINT64_C(0x100000000000) * (counts[c] - i);
                expected[i].key = keys[i];
                expected[i].index = (pbw_index)i;
            }
            qsort(expected, counts[c], sizeof *expected, compare_keyed);
            for (options.threads = 1; options.threads <= 7; options.threads += 3) {
                memset(order, 0xaa, sizeof order);
                CHECK_EQUAL(pbw_sort(keys, counts[c], &options, order), PBW_OK);
                for (i = 0; i < counts[c] && order[i] == expected[i].index; i++) {
                }
                CHECK(i == counts[c] && order[i] == 0xaaaaaaaa);
            }
        }
        test_end();
    }
    if (test_begin("a sort that fails")) {
        meter m;
        watch w;
        long k;
        for (i = 0; i < 200000; i++) {
            keys[i] = pbw_random(9, i);
        }
        options.resize = meter_resize;
        options.resize_user = &m;
        for (options.threads = 1; options.threads <= 2; options.threads++) {
            options.progress = NULL;
            for (k = 1; k < 20; k++) {
                pbw_status status;
                meter_start(&m, k, 0);
                status = pbw_sort(keys, 200000, &options, order);
                /* without memory for another thread it works on one */
                CHECK(status == (m.refused != 0 ? PBW_ERROR_MEMORY : PBW_OK)
                      || (status == PBW_OK && options.threads > 1));
                CHECK(status != PBW_OK || ascends(keys, order, 200000));
                CHECK(m.blocks == 0 && m.faults == 0 && (k > 2 || m.refused == 1));
            }
            CHECK(m.peak <= 16 * 200000 + 40000);
            options.progress = watch_progress;
            options.progress_user = &w;
            for (k = 1; k < 4; k++) {
                pbw_status status;
                meter_start(&m, 0, 0);
                watch_start(&w, (int)k);
                status = pbw_sort(keys, 200000, &options, order);
                CHECK(status == PBW_CANCELLED || (status == PBW_OK && w.calls < k));
                CHECK(w.wrong == 0 && m.blocks == 0 && m.faults == 0);
            }
        }
        CHECK_EQUAL(pbw_sort(NULL, 1, NULL, order), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_sort(keys, 1, NULL, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbw_sort(NULL, 0, NULL, NULL), PBW_OK);
        CHECK_EQUAL(pbw_sort(keys, (size_t)1 << 32, NULL, order), PBW_ERROR_TOO_LARGE);
        test_end();
    }
    if (test_begin("keys of doubles")) {
        static const double ascending[] = { -HUGE_VAL, -DBL_MAX, -1.5, -1, -DBL_MIN, -5e-324, 0, 5e-324, DBL_MIN, 1,
                                            1.5, DBL_MAX, HUGE_VAL };
        for (i = 1; i < sizeof ascending / sizeof *ascending; i++) {
            CHECK(pbw_sort_key(ascending[i - 1]) < pbw_sort_key(ascending[i]));
        }
        CHECK(pbw_sort_key(-0.0) == pbw_sort_key(0));
        CHECK(pbw_random(0, 0) == UINT64_C(0xe220a8397b1dcdaf) && pbw_random(0, 1) == UINT64_C(0x6e789e6aa1b965f4));
        test_end();
    }
}

/* --- exact numbers, against integers of 4608 bits --- */

typedef struct wide { int64_t limb[144]; } wide;     /* sum of limb[i] * 2^(32 i - 2200) */

static void wide_add(wide *w, double a, double b, int sign)
{
    int ea, eb, at, i;
    const int64_t x = (int64_t)ldexp(frexp(a, &ea), 53), y = (int64_t)ldexp(frexp(b, &eb), 53);
    const uint64_t p = (uint64_t)(x < 0 ? -x : x), q = (uint64_t)(y < 0 ? -y : y);
    uint64_t part[4];
    sign *= (x < 0) != (y < 0) ? -1 : 1;
    at = ea + eb - 106 + 2200;
    part[0] = (p & 0xffffffff) * (q & 0xffffffff);
    part[1] = (p & 0xffffffff) * (q >> 32);
    part[2] = (p >> 32) * (q & 0xffffffff);
    part[3] = (p >> 32) * (q >> 32);
    for (i = 0; x != 0 && y != 0 && i < 4; i++) {
        const int place = at + (i == 0 ? 0 : i == 3 ? 64 : 32), shift = place % 32;
        const uint64_t low = (part[i] & 0xffffffff) << shift, high = (part[i] >> 32) << shift;
        w->limb[place / 32] += sign * (int64_t)(low & 0xffffffff);
        w->limb[place / 32 + 1] += sign * (int64_t)((low >> 32) + (high & 0xffffffff));
        w->limb[place / 32 + 2] += sign * (int64_t)(high >> 32);
    }
}

static int wide_sign(wide w)
{
    int64_t carry = 0;
    int i, sign = 0;
    for (i = 0; i < 144; i++) {
        const int64_t value = w.limb[i] + carry;
        carry = value >= 0 ? value >> 32 : -((-value + 0xffffffff) >> 32);
        sign |= value - carry * ((int64_t)1 << 32) != 0;
    }
    return carry < 0 ? -1 : carry > 0 || sign;
}

static double some_double(uint64_t i, int range)
{
    const uint64_t bits = pbw_random(11, i);
    const double x = ldexp((double)(bits >> 11), (int)(bits % 2047) % (2 * range + 1) - range - 53);
    return bits & 2048 ? -x : x;
}

static void test_signs(void)
{
    if (test_begin("signs of sums of products")) {
        long seen[3] = { 0, 0, 0 };
        uint64_t drawn = 0;
        int round;
        for (round = 0; round < 30000; round++) {
            const int kind = round % 6, half = 1 + round / 6 % 8, range = kind < 2 ? 3 : kind < 4 ? 60 : 1000;
            double a[18], b[18];
            wide w;
            int i, count = 2 * half, sign;
            memset(&w, 0, sizeof w);
            for (i = 0; i < half; i++) {             /* pairs that cancel, all or but for a bit or a small product */
                a[i] = some_double(drawn++, range);
                b[i] = some_double(drawn++, range);
                a[half + i] = -b[i];
                b[half + i] = a[i];
            }
            if (kind % 2 == 1) {
                a[half] = nextafter(a[half], drawn & 1 ? 1e300 : -1e300);
            } else if (round % 4 < 2) {
                a[count] = some_double(drawn++, range) * 1e-30;
                b[count++] = round % 3 == 0 ? 5e-324 : some_double(drawn++, range);
            }
            for (i = 0; i < count; i++) {
                wide_add(&w, a[i], b[i], 1);
            }
            sign = wide_sign(w);
            CHECK_EQUAL(pbw_sign_of_products(a, b, count), sign);
            seen[sign + 1]++;
        }
        CHECK(seen[0] > 1000 && seen[1] > 1000 && seen[2] > 1000);
        CHECK_EQUAL(pbw_sign_of_products(NULL, NULL, 0), 0);
        test_end();
    }
    if (test_begin("two_sum and two_product")) {
        uint64_t i;
        for (i = 0; i < 30000; i++) {
            const double a = some_double(2 * i, 200), b = some_double(2 * i + 1, i % 2 == 0 ? 200 : 3);
            const pbw_pair s = pbw_two_sum(a, b), p = pbw_two_product(a, b);
            wide sum, product;
            memset(&sum, 0, sizeof sum);
            memset(&product, 0, sizeof product);
            wide_add(&sum, a, 1, 1);
            wide_add(&sum, b, 1, 1);
            wide_add(&sum, s.head, 1, -1);
            wide_add(&sum, s.tail, 1, -1);
            wide_add(&product, a, b, 1);
            wide_add(&product, p.head, 1, -1);
            wide_add(&product, p.tail, 1, -1);
            CHECK(wide_sign(sum) == 0 && wide_sign(product) == 0);
            CHECK(fabs(p.tail) <= 1.2e-16 * fabs(p.head) && fabs(s.tail) <= 1.2e-16 * fabs(s.head));
        }
        test_end();
    }
}

/* --- centres and facets --- */

static void test_centres(void)
{
    int dim;
    for (dim = 2; dim <= 3 && test_begin("centres in %dD", dim); dim++) {
        uint64_t drawn = 0;
        int round, flat = 0, k, i;
        for (round = 0; round < 5000; round++) {     /* 2 c . b = |b|^2 - (w_b - w_a) for each edge b at corner a */
            double x[4][3], weight[4], centre[3], worst = 0, size = 0;
            const double *const corner[4] = { x[0], x[1], x[2], x[3] };
            const double thin = ldexp(1, -(round % 40));
            for (i = 0; i <= dim; i++) {
                for (k = 0; k < dim; k++) {
                    x[i][k] = some_double(drawn++, 0) * (k == dim - 1 ? thin : 1);
                }
                weight[i] = round % 2 == 0 ? 0 : some_double(drawn++, 0) * thin;
            }
            if ((dim == 2 ? pbw_orient2(x[0], x[1], x[2]) : pbw_orient3(x[0], x[1], x[2], x[3])) < 0) {
                double swap[3];
                memcpy(swap, x[1], sizeof swap);
                memcpy(x[1], x[2], sizeof swap);
                memcpy(x[2], swap, sizeof swap);
            }
            flat += !pbw_centre(dim, corner, round % 2 == 0 ? NULL : weight, centre);
            for (i = 1; i <= dim; i++) {
                double rest = weight[i] - weight[0];
                for (k = 0; k < dim; k++) {
                    const double edge = x[i][k] - x[0][k];
                    rest += edge * (2 * centre[k] - edge);
                    size = fmax(size, fabs(edge * centre[k]) + edge * edge);
                }
                worst = fmax(worst, fabs(rest));
            }
            CHECK(worst <= 1e-14 * (size + 1));
        }
        CHECK(flat < 100);
        test_end();
    }
    if (test_begin("corners of facets")) {
        static const double x[4][3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
        int i;
        for (i = 0; i < 4; i++) {
            const unsigned a = PBW_FACET_CORNER(i, 0), b = PBW_FACET_CORNER(i, 1), c = PBW_FACET_CORNER(i, 2);
            CHECK(a < b && a < c && b != c && (int)a != i && (int)b != i && (int)c != i && b < 4 && c < 4);
            CHECK(pbw_orient3(x[a], x[b], x[c], x[i]) < 0 && pbw_orient3(x[0], x[1], x[2], x[3]) > 0);
        }
        test_end();
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 0);
    test_for();
    test_limit_of_many();
    test_arrays();
    test_nested();
    test_sort();
    test_signs();
    test_centres();
    test_order();
    test_backend();
    test_borrow();
    test_conflicts();
    test_hashes();
    return test_finish();
}
