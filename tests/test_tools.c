/* test_tools.c: what companion headers build on: pbw_for, pbw_order, pbw_conflict2 and 3, the partial hash, and the
   flags PBW_CURVE_ORDER and PBW_BORROW. */
#include "../pbw.h"
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

int main(int argc, char **argv)
{
    test_start(argc, argv, 0);
    test_for();
    test_order();
    test_backend();
    test_borrow();
    test_conflicts();
    test_hashes();
    return test_finish();
}
