/* test_query.c: what pbw.h answers about finished meshes, against brute force in exact arithmetic: location,
   stars, nearest vertices, vertices in a ball; for all inputs of the zoo, with queries at corners, on edges. */
#include "pbw_query.h"
#include "inputs.h"
#include "meshes.h"
#include "meter.h"
#include "oracle.h"
#include "test.h"
#include "watch.h"
#include <float.h>
#include <pthread.h>

enum { MOST = 400 };

typedef struct questions {
    size_t count;
    double points[3 * MOST];
} questions;

/* Queries of all kinds: vertices, middles of corners of a simplex (on edges, facets, inside), near and far points. */
static void ask(const pbw_mesh *mesh, size_t count, uint64_t seed, questions *q)
{
    uint64_t state = seed;
    const size_t dim = (size_t)mesh->dim;
    double low[3] = { 0, 0, 0 }, high[3] = { 0, 0, 0 };
    size_t i, k, j;
    for (i = 0; i < mesh->point_count; i++) {
        for (k = 0; k < dim; k++) {
            double x = mesh->points[i * dim + k];
            low[k] = i == 0 || x < low[k] ? x : low[k];
            high[k] = i == 0 || x > high[k] ? x : high[k];
        }
    }
    q->count = count;
    for (i = 0; i < count; i++) {
        double *p = q->points + i * dim;
        unsigned kind = input_below(&state, 8), corners = 1 + input_below(&state, (uint32_t)dim + 1);
        const pbw_index *v = mesh->simplex_count == 0 ? NULL
                           : mesh->simplices + input_below(&state, (uint32_t)mesh->simplex_count) * (dim + 1);
        for (k = 0; k < dim; k++) {
            p[k] = low[k] / 2 + high[k] / 2 + (high[k] / 2 - low[k] / 2) * (2 * input_uniform(&state) - 1);
            if (kind < 4 && v != NULL) {
                double sum = 0;
                for (j = 0; j < corners; j++) {
                    sum += mesh->points[v[j] * dim + k] / corners;
                }
                p[k] = sum;
            } else if (kind == 4) {
                p[k] = p[k] * 2 - low[k];
            } else if (kind == 5 && mesh->point_count > 0) {
                p[k] = mesh->points[(i % mesh->point_count) * dim + k];
            } else if (kind == 6) {
                p[k] = (double)input_below(&state, 9) / 2;
            }
            p[k] = p[k] - p[k] == 0 ? p[k] : DBL_MAX / 3;
        }
    }
}

/* --- location --- */
static int side(const pbw_mesh *mesh, size_t t, int i, const double *p)      /* of p, at the place of corner i */
{
    const size_t dim = (size_t)mesh->dim;
    const double *x[4];
    size_t k;
    for (k = 0; k <= dim; k++) {
        x[k] = mesh->points + mesh->simplices[t * (dim + 1) + k] * dim;
    }
    x[i] = p;
    return dim == 2 ? pbw_orient2(x[0], x[1], x[2]) : pbw_orient3(x[0], x[1], x[2], x[3]);
}

static pbw_index locate_slowly(const pbw_mesh *mesh, const double *p)
{
    size_t t;
    int i;
    for (t = 0; t < mesh->simplex_count; t++) {
        for (i = 0; i <= mesh->dim && side(mesh, t, i, p) >= 0; i++) {
        }
        if (i > mesh->dim) {
            return (pbw_index)t;
        }
    }
    return PBW_NONE;
}

static void check_place(const pbw_mesh *mesh, const double *p, pbw_index right, pbw_index found, pbw_index facet)
{
    const pbw_index corners = (pbw_index)mesh->dim + 1;
    CHECK_EQUAL(found, right);
    if (found != PBW_NONE || mesh->simplex_count == 0) {
        CHECK_EQUAL(facet, PBW_NONE);
    } else if (CHECK(facet < corners * mesh->simplex_count)) {
        CHECK_EQUAL(mesh->neighbors[facet], PBW_NONE);
        CHECK(side(mesh, facet / corners, (int)(facet % corners), p) < 0);
    }
}

static void check_locate(const pbw_mesh *mesh, const questions *q)
{
    const size_t dim = (size_t)mesh->dim;
    pbw_index found[MOST], facets[MOST], one, facet, hint;
    uint64_t state = 5;
    pbw_finder *finder = NULL;
    size_t i;
    CHECK_EQUAL(pbw_locate(mesh, q->points, q->count, NULL, found, facets), PBW_OK);
    CHECK_EQUAL(pbw_finder_create(mesh, NULL, &finder), PBW_OK);
    for (i = 0; i < q->count && test_faults == 0; i++) {
        const double *p = q->points + i * dim;
        pbw_index right = locate_slowly(mesh, p);
        check_place(mesh, p, right, found[i], facets[i]);
        for (hint = 0; hint < 3; hint++) {
            pbw_index from = hint == 2 || mesh->simplex_count == 0 ? PBW_NONE
                           : input_below(&state, (uint32_t)mesh->simplex_count);
            one = pbw_locate_one(mesh, p, from, &facet);
            check_place(mesh, p, right, one, facet);
        }
        one = pbw_finder_locate(finder, p, &facet);
        check_place(mesh, p, right, one, facet);
    }
    pbw_finder_free(finder);
}

/* --- distances, exactly: the sign of |a-p|^2 - wa - (|b-p|^2 - wb); b PBW_NONE: of the square of a radius --- */
static int compare_exactly(const pbw_mesh *mesh, const double *p, pbw_index a, pbw_index b, double radius)
{
    static oracle_big sum, x, y, square;
    const int dim = mesh->dim;
    double numbers[9], weights[2] = { 0, 0 };
    int unit, side_of, k;
    memcpy(numbers, p, (size_t)dim * sizeof *p);
    memcpy(numbers + dim, mesh->points + a * (size_t)dim, (size_t)dim * sizeof *p);
    for (k = 0; k < dim; k++) {
        numbers[2 * dim + k] = b != PBW_NONE ? mesh->points[b * (size_t)dim + (size_t)k] : radius;
    }
    if (mesh->weights != NULL) {
        weights[0] = mesh->weights[a];
        weights[1] = b != PBW_NONE ? mesh->weights[b] : 0;
    }
    unit = oracle_unit(1, 3 * dim, numbers, NULL);
    k = oracle_unit(1, 2, weights, weights);
    unit = k < unit ? k : unit;
    sum.sign = sum.length = 0;
    for (side_of = 0; side_of < 2; side_of++) {
        for (k = 0; k < (side_of == 1 && b == PBW_NONE ? 1 : dim); k++) {
            oracle_from_double(&x, numbers[(side_of + 1) * dim + k], unit);
            oracle_from_double(&y, side_of == 1 && b == PBW_NONE ? 0 : numbers[k], unit);
            oracle_add(&x, &y, -1);
            oracle_multiply(&square, &x, &x);
            oracle_add(&sum, &square, side_of == 0 ? 1 : -1);
        }
        oracle_from_double(&x, weights[side_of], 2 * unit);
        oracle_add(&sum, &x, side_of == 0 ? -1 : 1);
    }
    return sum.sign;
}

/* The same by doubles where they tell, which the exact one confirms now and then. */
static int compare(const pbw_mesh *mesh, const double *p, pbw_index a, pbw_index b, double radius)
{
    const size_t dim = (size_t)mesh->dim;
    double x = 0, y = b == PBW_NONE ? radius * radius : 0, size;
    size_t k;
    for (k = 0; k < dim; k++) {
        double dx = mesh->points[a * dim + k] - p[k], dy = b != PBW_NONE ? mesh->points[b * dim + k] - p[k] : 0;
        x += dx * dx;
        y += dy * dy;
    }
    size = x + y;
    if (mesh->weights != NULL) {
        x -= mesh->weights[a];
        y -= b != PBW_NONE ? mesh->weights[b] : 0;
        size += fabs(mesh->weights[a]) + (b != PBW_NONE ? fabs(mesh->weights[b]) : 0);
    }
    if (size > 1e-250 && size < 1e300 && fabs(x - y) > 1e-14 * size) {
        return x > y ? 1 : -1;
    }
    return compare_exactly(mesh, p, a, b, radius);
}

static int is_candidate(const pbw_mesh *mesh, pbw_index v)
{
    return mesh->simplex_count > 0 ? mesh->incident[v] != PBW_NONE : mesh->canonical[v] == v;
}

/* For each query the vertices in order of distance, by binary insertion: the first `most`, or all. */
typedef struct ranking { size_t most, *count; pbw_index *order; } ranking;

static size_t order_slowly(const pbw_mesh *mesh, const double *p, size_t most, pbw_index *order)
{
    size_t count = 0, low, high, middle;
    pbw_index v;
    for (v = 0; v < mesh->point_count; v++) {
        if (is_candidate(mesh, v)) {
            for (low = 0, high = count; low < high; ) {          /* behind all that are nearer or as near */
                middle = (low + high) / 2;
                if (compare(mesh, p, v, order[middle], 0) < 0) {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            if (low < most) {
                count += count < most;
                memmove(order + low + 1, order + low, (count - 1 - low) * sizeof *order);
                order[low] = v;
            }
        }
    }
    return count;
}

static ranking rank(const pbw_mesh *mesh, const questions *q, size_t most)
{
    ranking r;
    size_t i;
    r.most = most;
    r.count = (size_t *)zoo_grow(NULL, q->count * sizeof *r.count);
    r.order = (pbw_index *)zoo_grow(NULL, q->count * most * sizeof *r.order);
    for (i = 0; i < q->count; i++) {
        r.count[i] = order_slowly(mesh, q->points + i * (size_t)mesh->dim, most, r.order + i * most);
    }
    return r;
}

static void check_distance(const pbw_mesh *mesh, const double *p, pbw_index v, double distance)
{
    const size_t dim = (size_t)mesh->dim;
    long double sum = 0, size;
    size_t k;
    for (k = 0; k < dim; k++) {
        long double x = (long double)mesh->points[v * dim + k] - (long double)p[k];
        sum += x * x;
    }
    size = sum;
    if (mesh->weights != NULL) {
        size += fabsl((long double)mesh->weights[v]);
        CHECK(fabsl((long double)distance - (sum - (long double)mesh->weights[v])) <= 1e-14L * size
              || size > 1e300L || size < 1e-290L);
    } else if (sizeof(long double) > sizeof(double) && LDBL_MAX_EXP > 2 * DBL_MAX_EXP) {
        CHECK(sqrtl(sum) > (long double)DBL_MAX ? distance > DBL_MAX
              : fabsl((long double)distance - sqrtl(sum)) <= 1e-14L * sqrtl(sum) + 1e-320L);
    }
}

static void check_nearest(const pbw_mesh *mesh, const pbw_lists *stars, const questions *q, const ranking *r, size_t k)
{
    const size_t dim = (size_t)mesh->dim;
    pbw_index *found = (pbw_index *)malloc(q->count * k * sizeof *found);
    double *distances = (double *)malloc(q->count * k * sizeof *distances);
    size_t i, j;
    CHECK(k <= r->most);
    CHECK_EQUAL(pbw_nearest(mesh, stars, q->points, q->count, k, NULL, found, distances), PBW_OK);
    for (i = 0; i < q->count && test_faults == 0; i++) {
        const double *p = q->points + i * dim;
        const pbw_index *right = r->order + i * r->most;
        for (j = 0; j < k; j++) {
            if (j < r->count[i]) {
                CHECK_EQUAL(found[i * k + j], right[j]);
                check_distance(mesh, p, right[j], distances[i * k + j]);
            } else {
                CHECK_EQUAL(found[i * k + j], PBW_NONE);
                CHECK(distances[i * k + j] > DBL_MAX);
            }
        }
    }
    free(found);
    free(distances);
}

static void check_within(const pbw_mesh *mesh, const pbw_lists *stars, const questions *q, const ranking *r,
                         double radius)
{
    const size_t dim = (size_t)mesh->dim;
    pbw_lists lists;
    size_t i, j;
    CHECK(mesh->point_count <= r->most);
    CHECK_EQUAL(pbw_within(mesh, stars, q->points, q->count, radius, NULL, &lists), PBW_OK);
    CHECK_EQUAL(lists.count, q->count);
    for (i = 0; i < lists.count && test_faults == 0; i++) {
        const double *p = q->points + i * dim;
        const pbw_index *right = r->order + i * r->most;
        size_t length = lists.first[i + 1] - lists.first[i];
        for (j = 0; j < r->count[i] && compare(mesh, p, right[j], PBW_NONE, radius) <= 0; j++) {
            if (CHECK(j < length)) {
                CHECK_EQUAL(lists.item[lists.first[i] + j], right[j]);
                check_distance(mesh, p, right[j], lists.value[lists.first[i] + j]);
            }
        }
        CHECK_EQUAL(length, j);
    }
    pbw_lists_free(&lists);
}

/* --- stars --- */
static void check_stars(const pbw_mesh *mesh, const pbw_lists *stars)
{
    const size_t corners = (size_t)mesh->dim + 1;
    size_t v, i, j, k, links = 0, found = 0;
    CHECK_EQUAL(stars->count, mesh->point_count);
    for (i = 0; i < mesh->simplex_count && test_faults == 0; i++) {  /* each edge is there */
        for (j = 0; j < corners; j++) {
            for (k = 0; k < corners; k++) {
                pbw_index a = mesh->simplices[i * corners + j], b = mesh->simplices[i * corners + k];
                size_t at = stars->first[a];
                while (at < stars->first[a + 1] && stars->item[at] != b) {
                    at++;
                }
                CHECK((at < stars->first[a + 1]) == (a != b));
            }
        }
    }
    for (v = 0; v < mesh->point_count && test_faults == 0; v++) {    /* each once, and from both ends */
        links += stars->first[v + 1] - stars->first[v];
        for (i = stars->first[v]; i < stars->first[v + 1]; i++) {
            pbw_index u = stars->item[i];
            for (j = stars->first[v]; j < i; j++) {
                CHECK(stars->item[j] != u);
            }
            for (j = stars->first[u]; j < stars->first[u + 1]; j++) {
                found += stars->item[j] == v;
            }
        }
    }
    CHECK_EQUAL(links, found);
}

static void test_zoo(void)
{
    static questions q;
    zoo animals;
    size_t i;
    int dim;
    zoo_fill(&animals);
    for (dim = 2; dim <= 3; dim++) {
        zoo_kind(&animals, dim, INPUT_UNIFORM, 600);
        zoo_kind(&animals, dim, INPUT_CLUSTERS, 600);
        zoo_kind(&animals, dim, INPUT_LATTICE, 343);
        zoo_kind(&animals, dim, INPUT_LATTICE, 343);
        zoo_weigh(&animals, INPUT_WEIGHTS_LEVELS);
        zoo_kind(&animals, dim, INPUT_UNIFORM, 400);
        zoo_weigh(&animals, INPUT_WEIGHTS_HALF);
    }
    for (i = 0; i < animals.count; i++) {
        const zoo_input *in = animals.items + i;
        if (in->finite && in->count < 3000 && test_begin("%s", in->name)) {
            pbw_mesh mesh;
            pbw_lists stars;
            ranking r;
            pbw_status status = meshes_make(in, NULL, &mesh);
            CHECK(status == PBW_OK || status == PBW_DEGENERATE);
            CHECK_EQUAL(pbw_stars(&mesh, NULL, &stars), PBW_OK);
            check_stars(&mesh, &stars);
            ask(&mesh, in->count > 1000 ? 20 : 60, i + test_seed, &q);
            check_locate(&mesh, &q);
            q.count = in->count > 300 ? 8 : 30;
            r = rank(&mesh, &q, in->count > 70 && in->count < 400 ? in->count : 70);
            check_nearest(&mesh, &stars, &q, &r, 1);
            check_nearest(&mesh, &stars, &q, &r, 4);
            check_nearest(&mesh, NULL, &q, &r, 9);
            check_nearest(&mesh, &stars, &q, &r, 20);
            check_nearest(&mesh, &stars, &q, &r, 70);
            if (in->count > 1 && in->count < 400) {
                double r2 = 0;
                int k;
                for (k = 0; k < in->dim; k++) {
                    double x = in->points[k] - in->points[in->dim + k];
                    r2 += x * x;
                }
                if (r2 <= DBL_MAX) {
                    check_within(&mesh, &stars, &q, &r, sqrt(r2));
                }
                check_within(&mesh, NULL, &q, &r, 0);
            }
            free(r.order);
            free(r.count);
            pbw_lists_free(&stars);
            pbw_free(&mesh);
            test_end();
        }
    }
    zoo_free(&animals);
}

/* --- the same bytes for all threads, jobs and orders --- */
typedef struct answers {
    pbw_status status[7];
    pbw_lists lists[5];                 /* stars, a ball, the schemes */
    pbw_index *simplices, *vertices;
    double *distances;
} answers;

static void answer(const pbw_mesh *mesh, const double *points, size_t count, const pbw_options *options, answers *all)
{
    const double radius = 1.5 / (double)input_side(mesh->dim, mesh->point_count + 1);
    int i;
    memset(all, 0, sizeof *all);
    all->simplices = (pbw_index *)malloc(2 * count * sizeof(pbw_index));
    all->vertices = (pbw_index *)malloc(5 * count * sizeof(pbw_index));
    all->distances = (double *)malloc(5 * count * sizeof(double));
    all->status[0] = pbw_stars(mesh, options, &all->lists[0]);
    all->status[1] = pbw_locate(mesh, points, count, options, all->simplices, all->simplices + count);
    all->status[2] = pbw_nearest(mesh, NULL, points, count, 5, options, all->vertices, all->distances);
    all->status[3] = pbw_within(mesh, NULL, points, count, radius, options, &all->lists[1]);
    for (i = 0; i < 3; i++) {
        all->status[4 + i] = pbw_coordinates(mesh, points, count, (pbw_scheme)i, options, &all->lists[2 + i]);
    }
}

static void answers_free(answers *all)
{
    int i;
    for (i = 0; i < 5; i++) {
        pbw_lists_free(&all->lists[i]);
    }
    free(all->simplices);
    free(all->vertices);
    free(all->distances);
}

static int lists_equal(const pbw_lists *a, const pbw_lists *b)
{
    return a->count == b->count && memcmp(a->first, b->first, (a->count + 1) * sizeof *a->first) == 0
        && memcmp(a->item, b->item, a->first[a->count] * sizeof *a->item) == 0
        && (a->value == NULL) == (b->value == NULL)
        && (a->value == NULL || memcmp(a->value, b->value, a->first[a->count] * sizeof *a->value) == 0);
}

static void check_answers(const answers *a, const answers *b, size_t count)
{
    int i;
    for (i = 0; i < 7; i++) {
        CHECK_EQUAL(a->status[i], PBW_OK);
        CHECK_EQUAL(b->status[i], PBW_OK);
    }
    for (i = 0; i < 5 && test_faults == 0; i++) {
        CHECK(lists_equal(&a->lists[i], &b->lists[i]));
    }
    CHECK(memcmp(a->simplices, b->simplices, 2 * count * sizeof(pbw_index)) == 0);
    CHECK(memcmp(a->vertices, b->vertices, 5 * count * sizeof(pbw_index)) == 0);
    CHECK(memcmp(a->distances, b->distances, 5 * count * sizeof(double)) == 0);
}

static void run_backwards(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    *(int *)user += tasks;
    while (tasks-- > 0) {
        task(arg, tasks);
    }
}

static void test_threads(void)
{
    static const int kinds[] = { INPUT_UNIFORM, INPUT_LATTICE, INPUT_CLUSTERS };
    enum { N = 2000, QUERIES = 2000 };
    double *points = (double *)malloc(3 * N * sizeof *points);
    double *queries = (double *)malloc(3 * QUERIES * sizeof *queries);
    double *turned = (double *)malloc(3 * QUERIES * sizeof *queries);
    size_t kind, i;
    int dim, k, jobs = 0;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < 3; kind++) {
            if (test_begin("%dD %s: one answer for 1, 3, 8 threads, jobs, other orders", dim,
                           input_name(kinds[kind]))) {
                pbw_options options;
                pbw_mesh mesh;
                answers one, other;
                memset(&options, 0, sizeof options);
                input_fill(kinds[kind], dim, N, test_seed, points);
                input_fill(kinds[kind], dim, QUERIES, test_seed + 1, queries);
                for (i = 0; i < (size_t)dim * QUERIES && kinds[kind] == INPUT_LATTICE; i++) {
                    queries[i] = queries[i] / 2 - 1;
                }
                CHECK_EQUAL(pbw_triangulate(dim, points, NULL, N, NULL, &mesh), PBW_OK);
                options.threads = 1;
                answer(&mesh, queries, QUERIES, &options, &one);
                for (k = 0; k < 3; k++) {
                    options.threads = k == 0 ? 3 : 8;
                    options.run = k == 2 ? run_backwards : NULL;
                    options.run_user = &jobs;
                    answer(&mesh, queries, QUERIES, &options, &other);
                    check_answers(&one, &other, QUERIES);
                    answers_free(&other);
                }
                CHECK(jobs > 0);
                for (i = 0; i < QUERIES; i++) {
                    memcpy(turned + i * (size_t)dim, queries + (QUERIES - 1 - i) * (size_t)dim,
                           (size_t)dim * sizeof *turned);
                }
                answer(&mesh, turned, QUERIES, NULL, &other);
                for (i = 0; i < QUERIES; i++) {
                    const size_t j = QUERIES - 1 - i, length = one.lists[3].first[i + 1] - one.lists[3].first[i];
                    CHECK_EQUAL(one.simplices[i], other.simplices[j]);
                    CHECK(memcmp(one.vertices + 5 * i, other.vertices + 5 * j, 5 * sizeof(pbw_index)) == 0);
                    CHECK(length == other.lists[3].first[j + 1] - other.lists[3].first[j]
                          && memcmp(one.lists[3].value + one.lists[3].first[i],
                                    other.lists[3].value + other.lists[3].first[j], length * sizeof(double)) == 0);
                }
                answers_free(&other);
                answers_free(&one);
                pbw_free(&mesh);
                test_end();
            }
        }
    }
    free(points);
    free(queries);
    free(turned);
}

/* --- many threads of the caller's on one mesh --- */
typedef struct visitor {
    pthread_t thread;
    const pbw_mesh *mesh;
    const double *points;
    size_t count;
    uint64_t sum;
} visitor;

static void *visit(void *argument)
{
    visitor *v = (visitor *)argument;
    const size_t dim = (size_t)v->mesh->dim;
    pbw_options options;
    pbw_index at = 0, *found = (pbw_index *)malloc(4 * v->count * sizeof *found);
    pbw_lists lists;
    size_t i;
    memset(&options, 0, sizeof options);
    options.threads = 1;
    for (i = 0; i < v->count; i++) {
        pbw_index t = pbw_locate_one(v->mesh, v->points + i * dim, at, NULL);
        v->sum += t;
        at = t != PBW_NONE ? t : at;
    }
    pbw_nearest(v->mesh, NULL, v->points, v->count, 4, &options, found, NULL);
    for (i = 0; i < 4 * v->count; i++) {
        v->sum = v->sum * 31 + found[i];
    }
    pbw_coordinates(v->mesh, v->points, v->count, PBW_SIBSON, &options, &lists);
    v->sum += lists.first[lists.count];
    pbw_lists_free(&lists);
    free(found);
    return NULL;
}

static void test_visitors(void)
{
    enum { N = 3000, QUERIES = 2000, THREADS = 8 };
    double *points = (double *)malloc(3 * N * sizeof *points);
    double *queries = (double *)malloc(3 * QUERIES * sizeof *queries);
    int dim, i;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("%dD: 8 threads ask one mesh", dim)) {
            visitor visitors[THREADS];
            pbw_mesh mesh;
            input_fill(INPUT_UNIFORM, dim, N, 3, points);
            input_fill(INPUT_GAUSS, dim, QUERIES, 4, queries);
            CHECK_EQUAL(pbw_triangulate(dim, points, NULL, N, NULL, &mesh), PBW_OK);
            memset(visitors, 0, sizeof visitors);
            for (i = 0; i < THREADS; i++) {
                visitors[i].mesh = &mesh;
                visitors[i].points = queries;
                visitors[i].count = QUERIES;
                CHECK_EQUAL(pthread_create(&visitors[i].thread, NULL, visit, visitors + i), 0);
            }
            for (i = 0; i < THREADS; i++) {
                pthread_join(visitors[i].thread, NULL);
                CHECK(visitors[i].sum == visitors[0].sum);
            }
            pbw_free(&mesh);
            test_end();
        }
    }
    free(points);
    free(queries);
}

/* --- memory, progress, arguments --- */
static pbw_status call(int which, const pbw_mesh *mesh, const double *points, size_t count,
                       const pbw_options *options)
{
    static pbw_index out[6 * 70000];
    static double distances[3 * 70000];
    pbw_lists lists;
    pbw_finder *finder;
    pbw_status status;
    memset(&lists, 0, sizeof lists);
    switch (which) {
    case 0: status = pbw_stars(mesh, options, &lists); break;
    case 1: status = pbw_locate(mesh, points, count, options, out, out + count); break;
    case 2: status = pbw_nearest(mesh, NULL, points, count, 3, options, out, distances); break;
    case 3: status = pbw_nearest(mesh, NULL, points, count < 50 ? count : 50, 80, options, out, NULL); break;
    case 4: status = pbw_within(mesh, NULL, points, count, 0.1, options, &lists); break;
    case 5: status = pbw_finder_create(mesh, options, &finder), pbw_finder_free(finder); break;
    default: status = pbw_coordinates(mesh, points, count, (pbw_scheme)(which - 6), options, &lists); break;
    }
    CHECK(status == PBW_OK || (lists.memory == NULL && lists.first == NULL && lists.count == 0));
    pbw_lists_free(&lists);
    return status;
}
enum { CALLS = 9 };

static void test_memory(void)
{
    enum { N = 300, QUERIES = 200 };
    double points[3 * N], queries[3 * QUERIES];
    int dim, which, threads;
    long k;
    for (dim = 2; dim <= 3; dim++) {
        for (which = 0; which < CALLS; which++) {
            if (test_begin("%dD, call %d: every allocation fails once", dim, which)) {
                pbw_mesh mesh;
                pbw_options options;
                size_t peak;
                meter m;
                input_fill(INPUT_UNIFORM, dim, N, 1, points);
                input_fill(INPUT_UNIFORM, dim, QUERIES, 2, queries);
                CHECK_EQUAL(pbw_triangulate(dim, points, NULL, N, NULL, &mesh), PBW_OK);
                for (threads = 1; threads <= 3; threads += 2) {
                    for (k = 1; k < 1000; k++) {
                        pbw_status status;
                        meter_start(&m, k, k % 2 != 0);
                        memset(&options, 0, sizeof options);
                        options.resize = meter_resize;
                        options.resize_user = &m;
                        options.threads = threads;
                        status = call(which, &mesh, queries, QUERIES, &options);
                        CHECK(m.faults == 0 && m.blocks == 0 && m.bytes == 0);
                        if (m.refused == 0) {
                            CHECK_EQUAL(status, PBW_OK);
                            break;
                        }
                        CHECK_EQUAL(status, PBW_ERROR_MEMORY);
                    }
                    CHECK(k > 2);
                    peak = m.peak;
                    meter_start(&m, 0, 0);
                    options.memory_limit = peak - 1;
                    CHECK(threads > 1 || call(which, &mesh, queries, QUERIES, &options) == PBW_ERROR_MEMORY);
                    options.memory_limit = peak;
                    CHECK(threads > 1 || call(which, &mesh, queries, QUERIES, &options) == PBW_OK);
                    CHECK(m.blocks == 0);
                }
                pbw_free(&mesh);
                test_end();
            }
        }
    }
}

/* Grids in grids: eight clusters, each a hundredth of the one before in size, around two centres in turn.  A finder
   answers as pbw_locate does, and gives all memory back where an allocation fails. */
static void test_finder(void)
{
    enum { N = 1600 };
    double points[3 * N], queries[3 * N], size;
    pbw_index found[N];
    int dim, i, j;
    long k;
    for (dim = 2; dim <= 3 && test_begin("%dD, a finder in clusters", dim); dim++) {
        pbw_options options;
        pbw_finder *finder;
        pbw_mesh mesh;
        pbw_status status;
        meter m;
        input_fill(INPUT_UNIFORM, dim, N, 3, points);
        input_fill(INPUT_UNIFORM, dim, N, 4, queries);
        for (i = 0; i < N; i++) {
            for (size = 1, j = 0; j < i % 8; j++) {
                size *= 0.01;
            }
            for (j = 0; j < dim; j++) {
                points[i * dim + j] = points[i * dim + j] * size + i % 2 * 0.25;
                queries[i * dim + j] = queries[i * dim + j] * size + i % 2 * 0.25;
            }
        }
        CHECK_EQUAL(pbw_triangulate(dim, points, NULL, N, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_locate(&mesh, queries, N, NULL, found, NULL), PBW_OK);
        for (status = PBW_ERROR_MEMORY, k = 1; k < 1000 && status == PBW_ERROR_MEMORY; k++) {
            meter_start(&m, k, k % 2 != 0);
            memset(&options, 0, sizeof options);
            options.resize = meter_resize;
            options.resize_user = &m;
            status = pbw_finder_create(&mesh, &options, &finder);
            for (i = 0; i < N && status == PBW_OK; i++) {
                CHECK_EQUAL(pbw_finder_locate(finder, queries + i * dim, NULL), found[i]);
            }
            pbw_finder_free(finder);
            CHECK(m.faults == 0 && m.blocks == 0 && m.bytes == 0);
        }
        CHECK_EQUAL(status, PBW_OK);
        CHECK(k > 9);                                /* grids in grids */
        pbw_free(&mesh);
        test_end();
    }
}

/* More than four million vertices on a strip, where the longest axis of the grid has more than a million bins: as the
   finder asks no more of a mesh, these all say that they are corners of one triangle. */
static void test_strip(void)
{
    enum { N = 4300000 };
    static pbw_index corners[3] = { 1, 0, N - 1 }, across[3] = { PBW_NONE, PBW_NONE, PBW_NONE };
    double *points, q[2] = { 0.3, 6e-10 };
    pbw_index *incident;
    size_t i;
    if (test_begin("a finder on a strip")) {
        pbw_finder *finder;
        pbw_options options;
        pbw_mesh mesh;
        points = (double *)malloc(2 * N * sizeof *points);
        incident = (pbw_index *)calloc(N, sizeof *incident);
        for (i = 0; i < N; i++) {
            points[2 * i] = (double)i / N;
            points[2 * i + 1] = i % 2 == 0 ? 0 : 1e-9;
        }
        memset(&options, 0, sizeof options);
        memset(&mesh, 0, sizeof mesh);
        options.memory_limit = (size_t)1 << 30;
        mesh.dim = 2;
        mesh.point_count = N;
        mesh.simplex_count = 1;
        mesh.points = points;
        mesh.incident = mesh.canonical = incident;
        mesh.simplices = corners;
        mesh.neighbors = across;
        CHECK_EQUAL(pbw_finder_create(&mesh, &options, &finder), PBW_OK);
        CHECK_EQUAL(pbw_finder_locate(finder, q, NULL), 0);
        pbw_finder_free(finder);
        free(points);
        free(incident);
        test_end();
    }
}

static void test_progress(void)
{
    enum { N = 3000, QUERIES = 8000 };
    double *points = (double *)malloc(3 * N * sizeof *points);
    double *queries = (double *)malloc(3 * QUERIES * sizeof *queries);
    int which, threads, dim;
    long k;
    for (dim = 2; dim <= 3; dim++) {
        pbw_mesh mesh;
        input_fill(INPUT_UNIFORM, dim, N, 1, points);
        input_fill(INPUT_UNIFORM, dim, QUERIES, 2, queries);
        if (!CHECK_EQUAL(pbw_triangulate(dim, points, NULL, N, NULL, &mesh), PBW_OK)) {
            break;
        }
        for (which = 0; which < CALLS; which++) {
            if (test_begin("%dD, call %d: cancelled", dim, which)) {
                for (threads = 1; threads <= 3; threads += 2) {
                    for (k = 1; k < 1000 && test_faults == 0; k = k < 4 ? k + 1 : 2 * k) {
                        pbw_options options;
                        pbw_status status;
                        watch w;
                        meter m;
                        meter_start(&m, 0, 0);
                        watch_start(&w, k);
                        memset(&options, 0, sizeof options);
                        options.resize = meter_resize;
                        options.resize_user = &m;
                        options.progress = watch_progress;
                        options.progress_user = &w;
                        options.threads = threads;
                        status = call(which, &mesh, queries, QUERIES, &options);
                        CHECK(w.wrong == 0 && m.blocks == 0 && m.faults == 0);
                        CHECK_EQUAL(w.stages, 1 << PBW_STAGE_WORK);
                        if (w.calls < k) {
                            CHECK_EQUAL(status, PBW_OK);
                            CHECK(w.done == 1);
                            break;
                        }
                        CHECK_EQUAL(w.calls, k);
                        CHECK_EQUAL(status, PBW_CANCELLED);
                    }
                }
                test_end();
            }
        }
        pbw_free(&mesh);
    }
    free(points);
    free(queries);
}

/* Queries for many neighbours ask whether to go on after 32,768 of them, at most. */
static void test_many_ask(void)
{
    enum { N = 1500, QUERIES = 400, K = 1000 };
    double *points = (double *)malloc(2 * N * sizeof *points);
    double *queries = (double *)malloc(2 * QUERIES * sizeof *queries);
    pbw_index *found = (pbw_index *)malloc((size_t)K * QUERIES * sizeof *found);
    pbw_options options;
    pbw_mesh mesh;
    watch w;
    if (test_begin("many neighbours: questions")) {
        input_fill(INPUT_UNIFORM, 2, N, 1, points);
        input_fill(INPUT_UNIFORM, 2, QUERIES, 2, queries);
        CHECK_EQUAL(pbw_triangulate(2, points, NULL, N, NULL, &mesh), PBW_OK);
        watch_start(&w, 0);
        memset(&options, 0, sizeof options);
        options.progress = watch_progress;
        options.progress_user = &w;
        options.threads = 1;
        CHECK_EQUAL(pbw_nearest(&mesh, NULL, queries, QUERIES, K, &options, found, NULL), PBW_OK);
        CHECK(w.wrong == 0 && w.calls >= (long)K * QUERIES / 32768);
        pbw_free(&mesh);
        test_end();
    }
    free(points);
    free(queries);
    free(found);
}

static void test_arguments(void)
{
    enum { N = 50 };
    double points[3 * N], strided[4 * N], bad[6] = { 0.5, 0.5, 0.5, 0.5, 0.5, 0.5 };
    pbw_index out[3 * N], other[3 * N], facet;
    pbw_lists lists;
    pbw_options options;
    pbw_mesh mesh, bare, empty;
    pbw_finder *finder;
    int which, i;
    if (!test_begin("arguments")) {
        return;
    }
    input_fill(INPUT_UNIFORM, 3, N, 1, points);
    memset(&options, 0, sizeof options);
    memset(&empty, 0, sizeof empty);
    CHECK_EQUAL(pbw_triangulate(3, points, NULL, N, NULL, &mesh), PBW_OK);
    options.flags = PBW_NO_NEIGHBORS;
    CHECK_EQUAL(pbw_triangulate(3, points, NULL, N, &options, &bare), PBW_OK);
    options.flags = 0;
    for (which = 0; which < CALLS; which++) {
        CHECK_EQUAL(call(which, &bare, points, N, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(call(which, NULL, points, N, NULL), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(call(which, &empty, points, N, NULL), PBW_ERROR_ARGUMENT);
        options.threads = 257;
        CHECK_EQUAL(call(which, &mesh, points, N, &options), PBW_ERROR_ARGUMENT);
        options.threads = 0;
        if (which != 0 && which != 5) {
            CHECK_EQUAL(call(which, &mesh, NULL, N, NULL), PBW_ERROR_ARGUMENT);
            options.stride = 8;
            CHECK_EQUAL(call(which, &mesh, points, N, &options), PBW_ERROR_ARGUMENT);
            options.stride = 0;
            for (i = 0; i < 3; i++) {
                bad[3 + i % 3] = i == 0 ? HUGE_VAL : i == 1 ? -HUGE_VAL : HUGE_VAL - HUGE_VAL;
                CHECK_EQUAL(call(which, &mesh, bad, 2, NULL), PBW_ERROR_NOT_FINITE);
                CHECK_EQUAL(pbw_locate_one(&mesh, bad + 3, 0, &facet), PBW_NONE);
                CHECK_EQUAL(facet, PBW_NONE);
                bad[3 + i % 3] = 0.5;
            }
        }
        CHECK_EQUAL(call(which, &mesh, points, 0, NULL), PBW_OK);
        CHECK_EQUAL(call(which, &mesh, NULL, 0, NULL), PBW_OK);
    }
    CHECK_EQUAL(pbw_stars(&mesh, NULL, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_locate(&mesh, points, N, NULL, NULL, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_finder_create(&mesh, NULL, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_nearest(&mesh, NULL, points, N, 1, NULL, NULL, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_within(&mesh, NULL, points, N, -1, NULL, &lists), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_within(&mesh, NULL, points, N, HUGE_VAL, NULL, &lists), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_within(&mesh, NULL, points, N, HUGE_VAL - HUGE_VAL, NULL, &lists), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_coordinates(&mesh, points, N, (pbw_scheme)3, NULL, &lists), PBW_ERROR_ARGUMENT);
    memset(&lists, 0, sizeof lists);
    CHECK_EQUAL(pbw_nearest(&mesh, &lists, points, N, 1, NULL, out, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_locate_one(NULL, points, 0, &facet), PBW_NONE);
    CHECK_EQUAL(pbw_finder_locate(NULL, points, &facet), PBW_NONE);
    pbw_finder_free(NULL);
    pbw_lists_free(NULL);
    CHECK_EQUAL(pbw_finder_create(&mesh, NULL, &finder), PBW_OK);
    CHECK_EQUAL(pbw_finder_locate(finder, NULL, &facet), PBW_NONE);
    pbw_finder_free(finder);
    for (i = 0; i < N; i++) {
        memcpy(strided + 4 * i, points + 3 * i, 3 * sizeof *points);
        strided[4 * i + 3] = HUGE_VAL;
    }
    options.stride = 4 * sizeof(double);
    CHECK_EQUAL(pbw_nearest(&mesh, NULL, strided, N, 1, &options, out, NULL), PBW_OK);
    CHECK_EQUAL(pbw_nearest(&mesh, NULL, points, N, 1, NULL, other, NULL), PBW_OK);
    for (i = 0; i < N; i++) {
        CHECK(out[i] == other[i] && out[i] == (pbw_index)i);
    }
    pbw_free(&mesh);
    pbw_free(&bare);
    test_end();
}

/* Meshes of more than 1e9 simplices, of which only the last one is ever read: the number of its facet fits, or not. */
static void check_huge(int dim)
{
    static const double points[12] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1 }, flat[6] = { 0, 0, 1, 0, 0, 1 };
    static const double outside[3] = { -1, -1, -1 };
    const pbw_index corner[4] = { 0, 1, 2, 3 }, none[4] = { PBW_NONE, PBW_NONE, PBW_NONE, PBW_NONE };
    const size_t corners = (size_t)dim + 1, last = 4294967295u / corners;
    size_t t;
    for (t = last - 1; t < last + 2; t += 2) {
        const uintptr_t before = t * corners * sizeof(pbw_index);
        pbw_mesh mesh;
        pbw_index facet = 0;
        memset(&mesh, 0, sizeof mesh);
        mesh.dim = dim;
        mesh.points = dim == 3 ? points : flat;
        mesh.point_count = corners;
        mesh.simplex_count = t + 1;
        mesh.simplices = (const pbw_index *)((uintptr_t)corner - before);
        mesh.neighbors = (const pbw_index *)((uintptr_t)none - before);
        CHECK_EQUAL(pbw_locate_one(&mesh, outside, (pbw_index)t, &facet), PBW_NONE);
        CHECK(t < last ? facet / corners == t : facet == PBW_NONE);
    }
}

static void test_huge(void)
{
    if (test_begin("the number of a hull facet that does not fit")) {
        if (sizeof(size_t) > 4) {
            check_huge(2);
            check_huge(3);
        }
        test_end();
    }
}

/* --- the tree of boxes and the mesh give the same answers, to queries from afar too, alone and many: it is the mesh
   that answers few queries --- */
static void check_boxes(int kind, int dim, size_t n, size_t k)
{
    enum { ROOM = 8000, FOUND = 8 * ROOM };
    const size_t size = (size_t)dim, few = n / 10;
    static double points[3 * ROOM], queries[3 * ROOM], distances[2][FOUND];
    static pbw_index found[2][FOUND];
    pbw_mesh mesh;
    pbw_lists stars;
    size_t i;
    CHECK(n <= ROOM && n * k <= FOUND);
    input_fill(kind, dim, n, 1, points);
    input_fill(kind, dim, n, 2, queries);
    for (i = 0; i < n * size; i++) {
        const size_t row = i / size;
        queries[i] = row % 50 == 0 ? 0.0 : row % 7 == 1 ? points[i] : row % 7 == 2 ? points[i] + 0.5
                   : row % 101 == 3 || row > n / 4 * 3 ? 1e4 * queries[i] : queries[i];
    }
    CHECK_EQUAL(pbw_triangulate(dim, points, NULL, n, NULL, &mesh), PBW_OK);
    CHECK_EQUAL(pbw_stars(&mesh, NULL, &stars), PBW_OK);
    CHECK_EQUAL(pbw_nearest(&mesh, NULL, queries, n, k, NULL, found[0], distances[0]), PBW_OK);
    for (i = 0; i < n; i += few) {
        CHECK_EQUAL(pbw_nearest(&mesh, &stars, queries + i * size, few, k, NULL, found[1] + i * k,
                                distances[1] + i * k), PBW_OK);
    }
    CHECK(memcmp(found[0], found[1], n * k * sizeof(found[0][0])) == 0);
    CHECK(memcmp(distances[0], distances[1], n * k * sizeof(distances[0][0])) == 0);
    pbw_lists_free(&stars);
    pbw_free(&mesh);
}

static void test_boxes(void)
{
    const int kinds[5] = { INPUT_UNIFORM, INPUT_SPHERE, INPUT_CLUSTERS, INPUT_LATTICE, INPUT_LINES };
    int i;
    for (i = 0; i < 10; i++) {
        if (test_begin("nearest by boxes as by the mesh, %dD %s", 2 + i / 5, input_name(kinds[i % 5]))) {
            check_boxes(kinds[i % 5], 2 + i / 5, 1000, 2);
            check_boxes(kinds[i % 5], 2 + i / 5, 8000, 8);
            check_boxes(kinds[i % 5], 2 + i / 5, 1000, 64);
            test_end();
        }
    }
}

/* --- large meshes, in which several walks of a block take turns: the same answers as of single walks, and of a scan
   or the tree of boxes --- */
enum { TURN_QUERIES = 3000, TURN_POINTS = 66000 };

/* Queries of all kinds. */
static void ask_many(const pbw_mesh *mesh, double *queries)
{
    static questions q;
    size_t i;
    for (i = 0; i < TURN_QUERIES; i += q.count) {
        ask(mesh, TURN_QUERIES - i < MOST ? TURN_QUERIES - i : MOST, i + 1, &q);
        memcpy(queries + i * (size_t)mesh->dim, q.points, q.count * (size_t)mesh->dim * sizeof *queries);
    }
}

static void check_turns(int dim, int kind, size_t n, unsigned flags)
{
    static double points[3 * TURN_POINTS], weights[TURN_POINTS], queries[3 * TURN_QUERIES];
    static double distances[2][TURN_QUERIES];
    static pbw_index found[2][TURN_QUERIES], facets[2][TURN_QUERIES];
    const size_t size = (size_t)dim;
    pbw_options options;
    pbw_mesh mesh;
    pbw_lists stars;
    questions few;
    ranking r;
    size_t i, k;
    int weighted;
    memset(&options, 0, sizeof options);
    input_fill(kind, dim, n, 1, points);
    input_fill_weights(INPUT_WEIGHTS_HIDING, dim, n, 1, points, weights);
    for (weighted = 0; weighted < 2; weighted++) {
        options.flags = flags;
        CHECK_EQUAL(pbw_triangulate(dim, points, weighted ? weights : NULL, n, &options, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_stars(&mesh, NULL, &stars), PBW_OK);
        CHECK(mesh.simplex_count >= 65536);
        ask_many(&mesh, queries);
        options.flags = 0;
        for (i = 0; i < 2; i++) {
            options.threads = i == 0 ? 1 : 3;
            CHECK_EQUAL(pbw_locate(&mesh, queries, TURN_QUERIES, &options, found[i], facets[i]), PBW_OK);
        }
        CHECK(memcmp(found[0], found[1], sizeof found[0]) == 0);
        CHECK(memcmp(facets[0], facets[1], sizeof facets[0]) == 0);
        for (i = 0; i < TURN_QUERIES; i++) {
            const double *p = queries + i * size;
            check_place(&mesh, p, pbw_locate_one(&mesh, p, found[0][i], NULL), found[0][i], facets[0][i]);
        }
        CHECK_EQUAL(pbw_locate(&mesh, queries, 5, NULL, found[1], NULL), PBW_OK);     /* fewer than walks */
        CHECK(memcmp(found[0], found[1], 5 * sizeof found[0][0]) == 0);
        CHECK_EQUAL(pbw_nearest(&mesh, &stars, queries, TURN_QUERIES, 1, &options, found[0], distances[0]), PBW_OK);
        CHECK_EQUAL(pbw_nearest(&mesh, NULL, queries, TURN_QUERIES, 1, &options, found[1], distances[1]), PBW_OK);
        CHECK(memcmp(found[0], found[1], sizeof found[0]) == 0);
        CHECK(memcmp(distances[0], distances[1], sizeof distances[0]) == 0);
        ask(&mesh, 12, 9, &few);
        r = rank(&mesh, &few, 3);
        for (k = 1; k <= 3; k += 2) {
            check_nearest(&mesh, &stars, &few, &r, k);
        }
        free(r.count);
        free(r.order);
        pbw_lists_free(&stars);
        pbw_free(&mesh);
    }
}

/* Points that have moved: location ends. */
static void check_turns_moved(void)
{
    enum { N = 40000 };
    static double points[2 * N], queries[2 * N];
    static pbw_index found[N];
    pbw_options options;
    pbw_mesh mesh;
    memset(&options, 0, sizeof options);
    input_fill(INPUT_UNIFORM, 2, N, 1, points);
    input_fill(INPUT_UNIFORM, 2, N, 2, queries);
    options.flags = PBW_BORROW;
    CHECK_EQUAL(pbw_triangulate(2, points, NULL, N, &options, &mesh), PBW_OK);
    input_fill(INPUT_UNIFORM, 2, N, 3, points);
    CHECK_EQUAL(pbw_locate(&mesh, queries, N, NULL, found, NULL), PBW_ERROR_ARGUMENT);
    pbw_free(&mesh);
}

static void test_turns(void)
{
    const struct { int dim, kind; size_t n; unsigned flags; } cases[5] = {
        { 2, INPUT_UNIFORM, 40000, 0 }, { 2, INPUT_LATTICE, 40000, 0 }, { 3, INPUT_UNIFORM, 14000, 0 },
        { 3, INPUT_LATTICE, 18000, 0 }, { 2, INPUT_UNIFORM, TURN_POINTS, PBW_CURVE_ORDER }
    };
    int i;
    for (i = 0; i < 5; i++) {
        if (test_begin("walks in turn, %dD %s%s", cases[i].dim, input_name(cases[i].kind),
                       cases[i].flags == 0 ? "" : " along the curve")) {
            check_turns(cases[i].dim, cases[i].kind, cases[i].n, cases[i].flags);
            test_end();
        }
    }
    if (test_begin("walks in turn where points have moved")) {
        check_turns_moved();
        test_end();
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 1000);
    test_zoo();
    test_threads();
    test_visitors();
    test_memory();
    test_finder();
    test_strip();
    test_progress();
    test_many_ask();
    test_arguments();
    test_huge();
    test_boxes();
    test_turns();
    return test_finish();
}
