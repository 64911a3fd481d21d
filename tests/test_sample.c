/* test_sample.c: examples/lib/pbw_sample.h: that samples are where they should be, as dense, as far apart, as many, and
   the same whoever makes them; what bad surfaces are called; memory that runs out. */
#define _GNU_SOURCE
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include "../pbw.h"

static size_t held, most_held, fail_at, requests;
static int once;                                /* refuses request number fail_at only, else also all after it */

/* An allocator that counts bytes by what it is told of the old sizes, and refuses. */
static void *count_resize(void *user, void *ptr, size_t old_size, size_t new_size)
{
    void *block;
    (void)user;
    if (new_size == 0) {
        held -= old_size;
        free(ptr);
        return NULL;
    }
    requests++;
    if (fail_at != 0 && (once ? requests == fail_at : requests >= fail_at)) {
        return NULL;
    }
    block = realloc(ptr, new_size);
    held += block != NULL ? new_size - old_size : 0;
    most_held = held > most_held ? held : most_held;
    return block;
}

#define PBW_SAMPLE_IMPLEMENTATION
#include "../examples/lib/pbw_sample.h"
#include "test.h"

static double points[200000];
static pbw_index triangles[300000];

static pbwsample_model start_model(void)
{
    pbwsample_model model;
    memset(&model, 0, sizeof model);
    model.points = points;
    model.triangles = triangles;
    return model;
}

static void add_point(pbwsample_model *model, double x, double y, double z)
{
    double *p = points + 3 * model->point_count++;
    p[0] = x;
    p[1] = y;
    p[2] = z;
}

static void add_triangle(pbwsample_model *model, size_t a, size_t b, size_t c)
{
    pbw_index *t = triangles + 3 * model->triangle_count++;
    t[0] = (pbw_index)a;
    t[1] = (pbw_index)b;
    t[2] = (pbw_index)c;
}

/* Adds a grid of wide*high cells over the parallelogram at that corner. */
static void add_patch(pbwsample_model *model, size_t wide, size_t high, const double corner[3], const double u[3],
                      const double v[3])
{
    size_t first = model->point_count, i, j;
    for (j = 0; j <= high; j++) {
        for (i = 0; i <= wide; i++) {
            double s = (double)i / (double)wide, t = (double)j / (double)high;
            add_point(model, corner[0] + s * u[0] + t * v[0], corner[1] + s * u[1] + t * v[1],
                      corner[2] + s * u[2] + t * v[2]);
        }
    }
    for (j = 0; j < high; j++) {
        for (i = 0; i < wide; i++) {
            size_t a = first + j * (wide + 1) + i, b = a + wide + 1;
            add_triangle(model, a, a + 1, b);
            add_triangle(model, a + 1, b + 1, b);
        }
    }
}

static pbwsample_model square(size_t wide, size_t high)
{
    static const double corner[3] = { 0, 0, 0 }, u[3] = { 1, 0, 0 }, v[3] = { 0, 1, 0 };
    pbwsample_model model = start_model();
    add_patch(&model, wide, high, corner, u, v);
    return model;
}

/* The cube [0,1]^3; its faces have their own points, so that edges close at equal places only. */
static pbwsample_model cube(size_t cells)
{
    static const double zero[3] = { 0, 0, 0 }, one[3] = { 1, 1, 1 };
    static const double axis[3][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    static const double back[3][3] = { { -1, 0, 0 }, { 0, -1, 0 }, { 0, 0, -1 } };
    pbwsample_model model = start_model();
    int k;
    for (k = 0; k < 3; k++) {
        add_patch(&model, cells, cells, zero, axis[(k + 2) % 3], axis[(k + 1) % 3]);
        add_patch(&model, cells, cells, one, back[(k + 1) % 3], back[(k + 2) % 3]);
    }
    return model;
}

/* The unit sphere in rings around z, with triangles from small and thin to large. */
static pbwsample_model ball(size_t rings, size_t sides)
{
    pbwsample_model model = start_model();
    size_t i, j;
    add_point(&model, 0, 0, -1);
    for (i = 1; i < rings; i++) {
        for (j = 0; j < sides; j++) {
            double a = 3.141592653589793 * (double)i / (double)rings;
            double b = 6.283185307179586 * (double)j / (double)sides;
            add_point(&model, sin(a) * cos(b), sin(a) * sin(b), -cos(a));
        }
    }
    add_point(&model, 0, 0, 1);
    for (j = 0; j < sides; j++) {
        size_t next = (j + 1) % sides, last = 1 + (rings - 2) * sides;
        add_triangle(&model, 0, 1 + next, 1 + j);
        for (i = 0; i + 2 < rings; i++) {
            add_triangle(&model, 1 + i * sides + j, 1 + i * sides + next, 1 + (i + 1) * sides + j);
            add_triangle(&model, 1 + i * sides + next, 1 + (i + 1) * sides + next, 1 + (i + 1) * sides + j);
        }
        add_triangle(&model, last + j, last + next, model.point_count - 1);
    }
    return model;
}

static double distance(const double *a, const double *b)
{
    return sqrt(pbwsample__square(a, b));
}

static double nearest(const pbwsample_set *set, size_t begin, size_t end, const double *p)
{
    double best = DBL_MAX, d;
    size_t i;
    for (i = begin; i < end; i++) {
        d = pbwsample__square(set->points + 3 * i, p);
        best = d < best ? d : best;
    }
    return sqrt(best);
}

static double closest_pair(const pbwsample_set *set)
{
    double best = DBL_MAX, d;
    size_t i;
    for (i = 1; i < set->count; i++) {
        d = nearest(set, 0, i, set->points + 3 * i);
        best = d < best ? d : best;
    }
    return best;
}

/* Every sample lies in its triangle where it says. */
static void check_places(const pbwsample_model *model, const pbwsample_set *set, double diagonal)
{
    size_t i, k;
    for (i = 0; i < set->count; i++) {
        double u = set->places[2 * i], v = set->places[2 * i + 1], at[3];
        size_t t = set->triangles[i];
        if (!CHECK(t < model->triangle_count && u >= 0 && v >= 0 && u + v <= 1)) {
            return;
        }
        for (k = 0; k < 3; k++) {
            at[k] = (1 - u - v) * pbwsample__corner(model, t, 0)[k] + u * pbwsample__corner(model, t, 1)[k]
                  + v * pbwsample__corner(model, t, 2)[k];
        }
        CHECK(distance(at, set->points + 3 * i) <= 1e-14 * diagonal);
    }
}

/* Whether counts agree with expected ones, neither worse nor better than once in a thousand (Wilson and Hilferty
   1931, "The distribution of chi-square"). */
static int plausible(const double *found, const double *expected, size_t count)
{
    double sum = 0, k = (double)count - 1, z;
    size_t i;
    for (i = 0; i < count; i++) {
        sum += (found[i] - expected[i]) * (found[i] - expected[i]) / expected[i];
    }
    z = (cbrt(sum / k) - (1 - 2 / (9 * k))) / sqrt(2 / (9 * k));
    if (fabs(z) > 3.3) {
        test_say("chi-square %g of %g, z = %g", sum, k, z);
    }
    return fabs(z) <= 3.3;
}

static double wide_size(void *user, const double p[3])
{
    (void)user;
    return 1 + 2 * p[0] * p[0];
}

static double zero_size(void *user, const double p[3])
{
    (void)user;
    return p[0] > 0.5 ? 0 : 1;
}

static void test_uniform(void)
{
    static double found[5000], expected[5000];
    pbwsample_model model = ball(24, 50);
    pbwsample_options options;
    pbwsample_set set;
    size_t i, part;
    double sum = 0;
    int sized;
    memset(&options, 0, sizeof options);
    options.count = 500000;
    options.seed = test_seed;
    for (sized = 0; sized < 2; sized++) {
        options.size = sized ? wide_size : NULL;
        CHECK_EQUAL(pbwsample_uniform(&model, &options, &set), PBW_OK);
        CHECK_EQUAL(set.count, options.count);
        check_places(&model, &set, 3.5);
        for (i = 0, sum = 0; i < model.triangle_count; i++) {
            double x = (pbwsample__corner(&model, i, 0)[0] + pbwsample__corner(&model, i, 1)[0]
                        + pbwsample__corner(&model, i, 2)[0]) / 3, size = sized ? 1 + 2 * x * x : 1;
            expected[i] = pbwsample__area(&model, i) / (size * size);
            sum += expected[i];
            found[i] = 0;
        }
        for (i = 0; i < model.triangle_count; i++) {
            expected[i] *= (double)set.count / sum;
        }
        for (i = 0; i < set.count; i++) {
            found[set.triangles[i]]++;
        }
        CHECK(plausible(found, expected, model.triangle_count));
        memset(found, 0, 16 * sizeof *found);                        /* and 16 equal parts of each triangle */
        for (i = 0; i < set.count; i++) {
            size_t u = (size_t)(4 * set.places[2 * i]), v = (size_t)(4 * set.places[2 * i + 1]);
            int upper = 4 * (set.places[2 * i] + set.places[2 * i + 1]) - (double)(u + v) > 1;
            part = 7 * v - v * (v - 1) + 2 * u + (size_t)upper;
            found[(part > 15 ? 15 : part)] += 1;
        }
        for (i = 0; i < 16; i++) {
            expected[i] = (double)set.count / 16;
        }
        CHECK(plausible(found, expected, 16));
        pbwsample_free(&set);
    }
}

/* Job systems: backwards; on threads. */
static void run_backwards(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    (void)user;
    while (tasks-- > 0) {
        task(arg, tasks);
    }
}

typedef struct job { int next, step, tasks; void (*task)(void *arg, int i); void *arg; } job;

static void *work(void *data)
{
    job *j = (job *)data;
    for (; j->next < j->tasks; j->next += j->step) {
        j->task(j->arg, j->next);
    }
    return NULL;
}

static void run_on_threads(void *user, int tasks, void (*task)(void *arg, int i), void *arg)
{
    pthread_t threads[8];
    job jobs[8];
    int i, count = *(int *)user;
    for (i = 0; i < count; i++) {
        job j = { 0, 0, 0, NULL, NULL };
        j.next = i;
        j.step = count;
        j.tasks = tasks;
        j.task = task;
        j.arg = arg;
        jobs[i] = j;
        CHECK_EQUAL(pthread_create(threads + i, NULL, work, jobs + i), 0);
    }
    for (i = 0; i < count; i++) {
        pthread_join(threads[i], NULL);
    }
}

static int same(const pbwsample_set *a, const pbwsample_set *b)
{
    return a->count == b->count && memcmp(a->points, b->points, 3 * a->count * sizeof(double)) == 0
        && memcmp(a->triangles, b->triangles, a->count * sizeof(pbw_index)) == 0
        && memcmp(a->places, b->places, 2 * a->count * sizeof(double)) == 0
        && memcmp(a->normals, b->normals, 3 * a->count * sizeof(double)) == 0;
}

static void test_same(void)
{
    pbwsample_model model = ball(20, 30);
    pbwsample_options options;
    pbwsample_set a, b;
    pbw_options build;
    int threads;
    memset(&options, 0, sizeof options);
    memset(&build, 0, sizeof build);
    options.count = 300001;
    options.flags = PBWSAMPLE_NORMALS;
    build.run_user = &threads;
    CHECK_EQUAL(pbwsample_uniform(&model, &options, &a), PBW_OK);
    for (threads = 0; threads <= 8; threads++) {
        options.build = &build;
        build.run = threads == 0 ? run_backwards : run_on_threads;
        CHECK_EQUAL(pbwsample_uniform(&model, &options, &b), PBW_OK);
        CHECK(same(&a, &b));
        pbwsample_free(&b);
    }
    options.build = NULL;
    options.seed = 1;
    CHECK_EQUAL(pbwsample_uniform(&model, &options, &b), PBW_OK);
    CHECK(!same(&a, &b));
    pbwsample_free(&a);
    pbwsample_free(&b);
    options.count = 1000;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &a), PBW_OK);
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &b), PBW_OK);
    CHECK(same(&a, &b));
    pbwsample_free(&b);
    options.seed = 2;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &b), PBW_OK);
    CHECK(!same(&a, &b));
    pbwsample_free(&a);
    pbwsample_free(&b);
}

/* Apart, and no room left: on facets larger and smaller than the radius, with and without sizes. */
static void test_radius(void)
{
    static const double radius[] = { 0.3, 0.06, 0.045 };
    pbwsample_model model;
    pbwsample_options options;
    pbwsample_set set, probe;
    size_t i, j;
    int kind, sized;
    for (kind = 0; kind < 3; kind++) {
        for (sized = 0; sized < 2; sized++) {
            double worst = 0, least = DBL_MAX, d;
            model = kind == 0 ? cube(1) : kind == 1 ? ball(60, 90) : square(1, 200);
            memset(&options, 0, sizeof options);
            options.radius = radius[kind];
            options.seed = test_seed;
            options.size = sized ? wide_size : NULL;
            CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_OK);
            check_places(&model, &set, 3.5);
            options.count = 50000;
            CHECK_EQUAL(pbwsample_uniform(&model, &options, &probe), PBW_OK);
            for (i = 0; i < set.count; i++) {
                for (j = i + 1; j < set.count; j++) {
                    const double *p = set.points + 3 * i;
                    d = distance(p, set.points + 3 * j) / (sized ? wide_size(NULL, p) : 1);
                    least = d < least ? d : least;
                }
            }
            CHECK(least >= options.radius * (1 - 1e-15));
            for (i = 0; i < probe.count; i++) {
                double best = DBL_MAX;
                for (j = 0; j < set.count; j++) {
                    const double *p = set.points + 3 * j;
                    double size = sized ? wide_size(NULL, p) : 1;
                    d = pbwsample__square(p, probe.points + 3 * i) / (size * size);
                    best = d < best ? d : best;
                }
                worst = best > worst ? best : worst;
            }
            CHECK(sqrt(worst) <= options.radius * (1 + 1e-6));
            pbwsample_free(&set);
            pbwsample_free(&probe);
        }
    }
}

static void test_counts(void)
{
    static const size_t counts[] = { 1, 2, 3, 7, 20, 100, 999, 5000 };
    pbwsample_options options;
    pbwsample_report report;
    pbwsample_set set;
    size_t i;
    int kind;
    for (i = 0; i < 3 * 8; i++) {
        pbwsample_model model;
        kind = (int)i % 3;
        model = kind == 0 ? cube(3) : kind == 1 ? ball(40, 60) : square(1, 1);
        memset(&options, 0, sizeof options);
        options.seed = test_seed;
        options.count = counts[i / 3];
        CHECK_EQUAL(pbwsample_inspect(&model, NULL, &report), PBW_OK);
        CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_OK);
        CHECK_EQUAL(set.count, options.count);
        CHECK(set.count < 2 || closest_pair(&set) >= set.radius);
        if (set.count >= 999) {                                      /* against the hexagonal lattice */
            double rho = closest_pair(&set) / sqrt(2 * report.area / (sqrt(3) * (double)set.count));
            if (!CHECK(rho >= 0.68)) {
                test_say("%zu samples: rho %.3f", set.count, rho);
            }
        }
        pbwsample_free(&set);
    }
}

/* Needles and sheets, whose areas and volumes tell nothing of how far apart samples may be. */
static void test_thin_models(void)
{
    pbw_status status;
    static const double width[] = { 1e-3, 1e-9, 1e-100 };
    pbwsample_options options;
    pbwsample_set set;
    size_t i, k;
    for (i = 0; i < 2 * 3; i++) {
        pbwsample_model model = start_model();
        double w = width[i / 2];
        int solid = (int)(i % 2);
        memset(&options, 0, sizeof options);
        memset(&set, 0, sizeof set);
        options.seed = test_seed;
        options.count = 30;
        if (solid) {
            model = cube(1);
            for (k = 0; k < model.point_count; k++) {
                points[3 * k + 2] *= w;
            }
            status = pbwsample_volume(&model, &options, &set);
        } else {
            add_point(&model, 0, 0, 0);
            add_point(&model, 1, 0, 0);
            add_point(&model, 0, w, 0);
            add_triangle(&model, 0, 1, 2);
            status = pbwsample_poisson(&model, &options, &set);
        }
        if (solid && w < 1e-3) {             /* too thin for any dart */
            CHECK(status == PBW_OK || (status == PBW_DEGENERATE && set.count == 0));
        } else {
            CHECK_EQUAL(status, PBW_OK);
            CHECK_EQUAL(set.count, 30);
            CHECK(closest_pair(&set) >= set.radius && set.radius > 0.01);
        }
        pbwsample_free(&set);
    }
}

/* A speck far away from the surface makes the model more radii wide than an integer can count. */
static void test_far_speck(void)
{
    pbwsample_model model = square(1, 1);
    pbwsample_options options;
    pbwsample_set set;
    memset(&options, 0, sizeof options);
    options.seed = test_seed;
    options.count = 30;
    add_point(&model, -1e30, -1e60, 1e90);
    add_triangle(&model, model.point_count - 1, model.point_count - 1, model.point_count - 1);
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_OK);
    CHECK_EQUAL(set.count, 30);
    CHECK(closest_pair(&set) >= set.radius && set.radius > 0.01);
    pbwsample_free(&set);
}

/* The power spectrum of samples of a square, averaged over directions: below half the frequency of its peak it has
   less than a tenth of the peak's power on average.  White noise has power 1 everywhere. */
static void test_spectrum(void)
{
    enum { MOST = 64 };
    static double power[MOST + 1], modes[MOST + 1];
    pbwsample_model model = square(40, 40);
    pbwsample_options options;
    pbwsample_set set;
    double low = 0, count = 0;
    int x, y, bin, seed, peak = 0;
    size_t i;
    memset(&options, 0, sizeof options);
    memset(power, 0, sizeof power);
    memset(modes, 0, sizeof modes);
    options.count = 1500;
    for (seed = 0; seed < 4; seed++) {
        options.seed = test_seed + (uint64_t)seed;
        CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_OK);
        for (y = 0; y <= MOST; y++) {
            for (x = y == 0 ? 1 : -MOST; x <= MOST; x++) {
                double c = 0, s = 0;
                bin = (int)(sqrt((double)(x * x + y * y)) + 0.5);
                for (i = 0; i < set.count && bin <= MOST; i++) {
                    double a = 6.283185307179586 * (x * set.points[3 * i] + y * set.points[3 * i + 1]);
                    c += cos(a);
                    s += sin(a);
                }
                if (bin <= MOST) {
                    power[bin] += (c * c + s * s) / (double)set.count;
                    modes[bin]++;
                }
            }
        }
        pbwsample_free(&set);
    }
    for (bin = 1; bin <= MOST; bin++) {
        power[bin] /= modes[bin];
        peak = power[bin] > power[peak] ? bin : peak;
    }
    for (bin = 1; bin <= peak / 2; bin++) {
        low += power[bin];
        count++;
    }
    CHECK(peak > 30 && peak < 50 && power[peak] > 1.3);              /* sqrt(1500) is 39 */
    if (!CHECK(low / count < 0.1 * power[peak]) || test_verbose) {
        test_say("peak %.2f at %d, %.3f below half of that", power[peak], peak, low / count);
    }
}

static void test_thin(void)
{
    static const double low[3] = { 0, 0, 0 }, high[3] = { 0, 0, 0.001 }, u[3] = { 1, 0, 0 }, v[3] = { 0, 1, 0 };
    pbwsample_model model = start_model();
    pbwsample_options options;
    pbwsample_set one, two;
    add_patch(&model, 5, 5, low, v, u);
    add_patch(&model, 5, 5, high, u, v);
    memset(&options, 0, sizeof options);
    options.radius = 0.03;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &one), PBW_OK);
    options.flags = PBWSAMPLE_THIN;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &two), PBW_OK);
    CHECK((double)two.count > 1.9 * (double)one.count && (double)two.count < 2.1 * (double)one.count);
    pbwsample_free(&one);
    pbwsample_free(&two);
}

static void test_normals(void)
{
    static const double up[3] = { 0, 3, 4 };
    static double given[6];
    static pbw_index ids[3] = { 0, 0, 1 };
    pbwsample_model model = ball(40, 60);
    pbwsample_options options;
    pbwsample_set set;
    pbwsample__doubles made = { NULL, 0, 0 };
    pbw_memory memory;
    double n[3];
    size_t i;
    memset(&options, 0, sizeof options);
    options.count = 2000;
    options.flags = PBWSAMPLE_NORMALS;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_OK);
    for (i = 0; i < set.count; i++) {
        CHECK(fabs(pbwsample__dot(set.normals + 3 * i, set.normals + 3 * i) - 1) < 1e-12);
        CHECK(pbwsample__dot(set.normals + 3 * i, set.points + 3 * i) > 0.995);
    }
    pbwsample_free(&set);
    options.flags |= PBWSAMPLE_FACET_NORMALS;
    CHECK_EQUAL(pbwsample_uniform(&model, &options, &set), PBW_OK);
    for (i = 0; i < set.count; i++) {
        pbwsample__facet_normal(&model, set.triangles[i], n);
        CHECK(fabs(pbwsample__dot(n, set.normals + 3 * i) / sqrt(pbwsample__dot(n, n)) - 1) < 1e-12);
    }
    pbwsample_free(&set);
    model = cube(1);                     /* one triangle or two of a face meet at a corner, the angle is the same */
    pbw_memory_start(&memory, NULL);
    CHECK(pbwsample__point_normals(&memory, &model, &made));
    for (i = 0; i < model.point_count; i++) {
        double length = sqrt(pbwsample__dot(made.at + 3 * i, made.at + 3 * i)), d = 0;
        int k;
        for (k = 0; k < 3; k++) {
            d += made.at[3 * i + (size_t)k] * (2 * points[3 * i + (size_t)k] - 1) / length / sqrt(3.0);
        }
        CHECK(d > 1 - 1e-12);
    }
    PBW_RELEASE(&memory, made);
    CHECK_EQUAL(memory.used, 0);
    model = square(1, 1);                /* given ones; where they cancel or are zero, those of the facet */
    model.triangle_count = 1;
    model.normals = given;
    model.normal_count = 2;
    model.normal_ids = ids;
    options.flags = PBWSAMPLE_NORMALS;
    options.count = 10;
    memcpy(given, up, sizeof up);
    memcpy(given + 3, up, sizeof up);
    CHECK_EQUAL(pbwsample_uniform(&model, &options, &set), PBW_OK);
    CHECK(fabs(set.normals[1] - 0.6) < 1e-15 && fabs(set.normals[2] - 0.8) < 1e-15);
    pbwsample_free(&set);
    memset(given, 0, sizeof given);
    CHECK_EQUAL(pbwsample_uniform(&model, &options, &set), PBW_OK);
    CHECK(set.normals[0] <= 0 && set.normals[0] >= 0 && fabs(set.normals[2] - 1) < 1e-15);
    pbwsample_free(&set);
}

/* The inside of a cube is known, also for points above its edges and corners. */
static void test_inside(void)
{
    static double p[3 * 4096];
    static unsigned char inside[4096];
    pbwsample_model model = cube(4);
    size_t i, k, open, count = 0;
    for (open = 0; open < 2; open++) {
        model.triangle_count -= open;
        for (i = count = 0; i < 4096; i++) {
            int on = 0;
            for (k = 0; k < 3; k++) {
                p[3 * count + k] = (double)(i >> (4 * k) & 15) / 8 - 0.25;
                on |= i >> (4 * k) == 2 || (i >> (4 * k) & 15) == 2 || (i >> (4 * k) & 15) == 10;
            }
            count += !on;
        }
        CHECK_EQUAL(pbwsample_inside(&model, p, count, NULL, inside), PBW_OK);
        for (i = 0; i < count; i++) {
            int in = 1;
            for (k = 0; k < 3; k++) {
                in &= p[3 * i + k] > 0 && p[3 * i + k] < 1;
            }
            CHECK_EQUAL(inside[i], in);
        }
    }
}

/* Volume of the simplices whose centre is inside. */
static double meshed_volume(const pbwsample_model *model, const pbwsample_set *set)
{
    pbw_mesh mesh;
    double *centre, sum = 0;
    unsigned char *inside;
    size_t i, k;
    CHECK_EQUAL(pbw_triangulate(3, set->points, NULL, set->count, NULL, &mesh), PBW_OK);
    centre = (double *)calloc(mesh.simplex_count, 3 * sizeof *centre);
    inside = (unsigned char *)calloc(mesh.simplex_count, 1);
    for (i = 0; i < 12 * mesh.simplex_count; i++) {
        centre[i / 12 * 3 + i % 3] += 0.25 * set->points[3 * (size_t)mesh.simplices[i / 3] + i % 3];
    }
    CHECK_EQUAL(pbwsample_inside(model, centre, mesh.simplex_count, NULL, inside), PBW_OK);
    for (i = 0; i < mesh.simplex_count; i++) {
        double e[3][3];
        for (k = 0; k < 9; k++) {
            e[k / 3][k % 3] = set->points[3 * (size_t)mesh.simplices[4 * i + 1 + k / 3] + k % 3]
                            - set->points[3 * (size_t)mesh.simplices[4 * i] + k % 3];
        }
        sum += inside[i] ? (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1])
                            - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0])
                            + e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) / 6 : 0;
    }
    free(centre);
    free(inside);
    pbw_free(&mesh);
    return sum;
}

static void test_volume(void)
{
    static unsigned char inside[100000];
    pbwsample_model model;
    pbwsample_options options;
    pbwsample_report report;
    pbwsample_set set;
    size_t i, surface;
    int lattice, open;
    for (open = 0; open < 2; open++) {
        for (lattice = 0; lattice < 2; lattice++) {
            double volume, worst = 0, p[3];
            model = ball(40, 60);
            CHECK_EQUAL(pbwsample_inspect(&model, NULL, &report), PBW_OK);
            CHECK(report.closed && fabs(report.volume - 4.18879) < 0.05);
            model.triangle_count -= (size_t)open * 7;
            memset(&options, 0, sizeof options);
            options.seed = test_seed;
            options.flags = PBWSAMPLE_NORMALS;
            options.radius = 0.15;
            CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_OK);
            surface = set.count;
            options.radius = 0;
            options.flags = lattice ? PBWSAMPLE_LATTICE : 0;
            CHECK_EQUAL(pbwsample_volume(&model, &options, &set), PBW_OK);
            CHECK(set.count > 3 * surface / 2);
            CHECK(set.radius >= 0.15 && set.radius <= 0.15);
            CHECK_EQUAL(pbwsample_inside(&model, set.points, set.count, NULL, inside), PBW_OK);
            for (i = surface; i < set.count; i++) {
                CHECK(inside[i] && set.triangles[i] == PBW_NONE && !(set.normals[3 * i] > 0));
                CHECK(nearest(&set, 0, lattice ? surface : i, set.points + 3 * i) >= set.radius);
            }
            for (i = 0; i < 20000; i++) {                            /* no hole in it */
                uint64_t key = test_seed + 1000;
                int k;
                for (k = 0; k < 3; k++) {
                    p[k] = 2 * pbwsample__low_half(pbw_random(key, 3 * i + (size_t)k)) - 1;
                }
                if (pbwsample__dot(p, p) < 0.95) {
                    double d = nearest(&set, 0, set.count, p);
                    worst = d > worst ? d : worst;
                }
            }
            CHECK(worst <= 1.25 * 0.15);
            volume = meshed_volume(&model, &set);
            if (!CHECK(fabs(volume - report.volume) < 0.03 * report.volume)) {
                test_say("volume %g of %g", volume, report.volume);
            }
            pbwsample_free(&set);
        }
    }
    model = cube(2);                     /* by count; sizes; and what has no inside */
    memset(&options, 0, sizeof options);
    memset(&set, 0, sizeof set);
    options.count = 1234;
    CHECK_EQUAL(pbwsample_volume(&model, &options, &set), PBW_OK);
    CHECK_EQUAL(set.count, 1234);
    CHECK(closest_pair(&set) >= set.radius);
    pbwsample_free(&set);
    options.count = 5000;                /* of which an eighth was made first */
    CHECK_EQUAL(pbwsample_volume(&model, &options, &set), PBW_OK);
    CHECK_EQUAL(set.count, 5000);
    pbwsample_free(&set);
    options.count = 0;
    options.radius = 0.08;
    CHECK_EQUAL(pbwsample_volume(&model, &options, &set), PBW_OK);
    CHECK(closest_pair(&set) >= set.radius && (double)set.count * 0.08 * 0.08 * 0.08 > 0.67);
    for (i = 0; i < 60000; i++) {
        double p[3];
        int k;
        for (k = 0; k < 3; k++) {
            p[k] = pbwsample__low_half(pbw_random(test_seed, 3 * i + (size_t)k));
        }
        CHECK(nearest(&set, 0, set.count, p) <= 1.25 * 0.08);
    }
    pbwsample_free(&set);
    options.radius = 0.1;
    options.size = wide_size;
    for (lattice = 0; lattice < 2; lattice++) {
        size_t left = 0, right = 0;
        options.flags = lattice ? PBWSAMPLE_LATTICE : 0;
        CHECK_EQUAL(pbwsample_volume(&model, &options, &set), PBW_OK);
        for (i = 0; i < set.count; i++) {
            left += set.points[3 * i] < 0.15;
            right += set.points[3 * i] > 0.85;
        }
        if (!CHECK(left > 4 * right && right > 2)) {
            test_say("%zu, %zu", left, right);
        }
        pbwsample_free(&set);
    }
    model = square(2, 2);
    CHECK_EQUAL(pbwsample_volume(&model, &options, &set), PBW_DEGENERATE);
    CHECK_EQUAL(set.count, 0);
    pbwsample_free(&set);
}

static int refuse(void *user, pbw_stage stage, double done)
{
    CHECK(done >= 0 && done <= 1 && stage == PBW_STAGE_WORK);
    return --*(int *)user < 0;
}

static void test_bad(void)
{
    pbwsample_model model = square(2, 2), none;
    pbwsample_options options;
    pbwsample_report report;
    pbwsample_set set;
    pbw_options build;
    unsigned char inside;
    int patience = 3, k;
    memset(&options, 0, sizeof options);
    memset(&none, 0, sizeof none);
    add_point(&model, 5, 5, 5);                                      /* 9 points and 8 triangles so far */
    add_point(&model, 0, 0, -0.0);
    add_triangle(&model, 0, 1, 1);
    add_triangle(&model, 0, 1, 2);
    CHECK_EQUAL(pbwsample_inspect(&model, NULL, &report), PBW_OK);
    CHECK_EQUAL(report.unused_points, 2);
    CHECK_EQUAL(report.duplicate_points, 1);
    CHECK_EQUAL(report.flat_triangles, 2);
    CHECK(!report.closed && report.open_edges > 0 && fabs(report.area - 1) < 1e-12);
    options.radius = 0.2;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_OK);
    for (k = 0; k < (int)set.count; k++) {
        CHECK(set.triangles[k] < 8);
    }
    pbwsample_free(&set);
    model = square(1, 1);
    CHECK_EQUAL(pbwsample_inspect(&model, NULL, &report), PBW_OK);
    CHECK(report.open_edges == 4 && report.crowded_edges == 0 && report.turned_edges == 0);
    add_triangle(&model, 0, 2, 3);
    add_triangle(&model, 2, 1, 3);
    CHECK_EQUAL(pbwsample_inspect(&model, NULL, &report), PBW_OK);
    CHECK(report.crowded_edges == 2 && report.turned_edges == 1);
    model = cube(4);
    CHECK_EQUAL(pbwsample_inspect(&model, NULL, &report), PBW_OK);
    CHECK(report.closed && fabs(report.volume - 1) < 1e-12 && fabs(report.area - 6) < 1e-12);
    triangles[0] = (pbw_index)model.point_count;
    CHECK_EQUAL(pbwsample_inspect(&model, NULL, &report), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwsample_uniform(&model, &options, &set), PBW_ERROR_ARGUMENT);
    model = cube(3);
    CHECK_EQUAL(pbwsample_inspect(&none, NULL, &report), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwsample_poisson(NULL, &options, &set), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwsample_poisson(&model, NULL, &set), PBW_ERROR_ARGUMENT);
    options.count = 5;                                               /* and a radius */
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_ERROR_ARGUMENT);
    options.count = 0;
    options.radius = 1e-9;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_ERROR_TOO_LARGE);
    options.radius = 0.1;
    options.size = zero_size;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_ERROR_ARGUMENT);
    options.count = 5;
    CHECK_EQUAL(pbwsample_uniform(&model, &options, &set), PBW_ERROR_ARGUMENT);
    options.count = 0;
    options.size = NULL;
    memset(&build, 0, sizeof build);
    build.progress = refuse;
    build.progress_user = &patience;
    options.build = &build;
    options.radius = 0.01;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_CANCELLED);
    CHECK(set.count == 0 && set.points == NULL);
    patience = 0;
    CHECK_EQUAL(pbwsample_volume(&model, &options, &set), PBW_CANCELLED);
    CHECK_EQUAL(pbwsample_inspect(&model, &build, &report), PBW_CANCELLED);
    CHECK_EQUAL(pbwsample_inside(&model, points, 1, &build, &inside), PBW_CANCELLED);
    options.radius = 0;
    options.count = 5;
    CHECK_EQUAL(pbwsample_uniform(&model, &options, &set), PBW_CANCELLED);
    CHECK(set.count == 0 && set.points == NULL);
    options.count = 0;
    options.radius = 0.01;
    options.build = NULL;
    points[0] = HUGE_VAL;
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_ERROR_NOT_FINITE);
    model = square(1, 1);
    model.point_count = 0;
    for (k = 0; k < 4; k++) {
        add_point(&model, k, k, k);
    }
    CHECK_EQUAL(pbwsample_uniform(&model, &options, &set), PBW_DEGENERATE);
    CHECK_EQUAL(pbwsample_poisson(&model, &options, &set), PBW_DEGENERATE);
    for (k = -1; k < 8; k++) {
        CHECK(*pbwsample_status_string((pbw_status)(k + 1)) != 0);
    }
}

/* One call of each kind, on an empty set; the last adds to a set that holds samples. */
static pbw_status make(int kind, const pbwsample_model *model, const pbw_options *build, pbwsample_set *set)
{
    pbwsample_options options;
    pbwsample_report report;
    unsigned char inside[2];
    pbw_status status;
    memset(set, 0, sizeof *set);
    memset(&options, 0, sizeof options);
    options.flags = PBWSAMPLE_NORMALS;
    options.build = build;
    options.count = kind == 1 ? 0 : 200;
    options.radius = kind == 1 ? 0.2 : 0;
    if (kind == 5) {
        status = pbwsample_poisson(model, &options, set);
        options.count = 300;
        options.build = status == PBW_OK && build->memory_limit == 0 ? NULL : build;     /* the allocator stays */
        return status == PBW_OK ? pbwsample_volume(model, &options, set) : status;
    }
    return kind == 0 ? pbwsample_uniform(model, &options, set) : kind <= 2 ? pbwsample_poisson(model, &options, set)
         : kind == 3 ? pbwsample_volume(model, &options, set)
         : kind == 4 ? pbwsample_inside(model, points, 2, build, inside) : pbwsample_inspect(model, build, &report);
}

static void test_no_memory(void)
{
    pbwsample_model model = ball(8, 10);
    pbw_options build;
    pbwsample_set set;
    pbw_status status = PBW_OK;
    int kind;
    memset(&build, 0, sizeof build);
    build.threads = 1;
    build.resize = count_resize;
    for (kind = 0; kind < 14; kind++) {
        once = kind >= 7;
        requests = 1;
        for (fail_at = 1; requests + 1 >= fail_at && fail_at < 2000; fail_at++) {
            requests = 0;
            status = make(kind % 7, &model, &build, &set);
            CHECK(status == PBW_OK || status == PBW_ERROR_MEMORY);
            CHECK(status == PBW_OK ? kind % 7 == 3 || kind % 7 == 4 || kind % 7 == 6 || set.normals != NULL
                                   : set.count == (kind % 7 == 5 && set.points != NULL ? 200 : 0));
            pbwsample_free(&set);
            CHECK_EQUAL(held, 0);
        }
        CHECK_EQUAL(status, PBW_OK);
        CHECK(fail_at > 4);
    }
    fail_at = 0;
    once = 0;
}

/* At each level of the limit a call succeeds or says that memory is short, and never holds more. */
static void test_limit(void)
{
    pbwsample_model model = ball(8, 10);
    pbw_options build;
    pbwsample_set set;
    pbw_status status = PBW_OK;
    size_t most;
    int kind, part, failures;
    memset(&build, 0, sizeof build);
    build.threads = 1;
    build.resize = count_resize;
    for (kind = 0; kind < 7; kind++) {
        build.memory_limit = 0;
        most_held = 0;
        CHECK_EQUAL(make(kind, &model, &build, &set), PBW_OK);
        pbwsample_free(&set);
        most = most_held;
        for (part = 1, failures = 0; part <= 16; part++) {
            build.memory_limit = most * (size_t)part / 16;
            most_held = 0;
            status = make(kind, &model, &build, &set);
            CHECK(status == PBW_OK || status == PBW_ERROR_MEMORY);
            CHECK(most_held <= build.memory_limit);
            failures += status != PBW_OK;
            pbwsample_free(&set);
            CHECK_EQUAL(held, 0);
        }
        CHECK_EQUAL(status, PBW_OK);
        CHECK(failures > 4);
    }
}

int main(int argc, char **argv)
{
    static const struct { const char *name; void (*run)(void); } tests[] = {
        { "uniform samples follow the areas", test_uniform }, { "the same for every job system", test_same },
        { "apart and maximal by radius", test_radius }, { "exact counts, rho", test_counts },
        { "needles and sheets", test_thin_models }, { "a far speck", test_far_speck }, { "spectrum", test_spectrum },
        { "thin sheets", test_thin }, { "normals", test_normals },
        { "inside", test_inside }, { "volumes", test_volume }, { "bad surfaces and arguments", test_bad },
        { "every allocation fails", test_no_memory }, { "memory_limit", test_limit }
    };
    size_t i;
    test_start(argc, argv, 0);
    for (i = 0; i < sizeof tests / sizeof tests[0]; i++) {
        if (test_begin("%s", tests[i].name)) {
            tests[i].run();
            test_end();
        }
    }
    return test_finish();
}
