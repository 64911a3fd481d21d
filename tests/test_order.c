/* test_order.c: the order of the vertices is the one that the banner of >>order defines, whatever the number of
   threads; here by sorting each set of points by the keys of its own grid, one set after the other. */
#include <pthread.h>

#define PBW__TEST_SMALL_SHARES                       /* few points make many tasks */
#define PBW_STATIC                                   /* what is not tested here is not compiled */
#define PBW_IMPLEMENTATION
#include "../pbw.h"
#include "inputs.h"
#include "test.h"

typedef struct points { int dim; size_t count; double *x, *w; } points;

static points points_create(int dim, size_t count)
{
    points p;
    p.dim = dim;
    p.count = count;
    p.x = (double *)calloc(count * (size_t)dim, sizeof(double));
    p.w = NULL;
    if (p.x == NULL) {
        abort();
    }
    return p;
}

static void points_destroy(points *p)
{
    free(p->x);
    free(p->w);
}

typedef struct entry { uint64_t key; double x[4]; size_t index; } entry;

static int by_key(const void *a, const void *b)
{
    const entry *x = (const entry *)a, *y = (const entry *)b;
    return x->key < y->key ? -1 : x->key > y->key;
}

/* x, y, z; of equal points the heavier, then the one of lower index. */
static int by_place(const void *a, const void *b)
{
    const entry *x = (const entry *)a, *y = (const entry *)b;
    int k;
    for (k = 0; k < 3; k++) {
        if (x->x[k] != y->x[k]) {
            return x->x[k] < y->x[k] ? -1 : 1;
        }
    }
    return x->x[3] != y->x[3] ? (x->x[3] > y->x[3] ? -1 : 1) : x->index < y->index ? -1 : 1;
}

/* Puts the entries into order; returns how deep grids lie in grids. */
static int sort_entries(const pbw__curve *curve, entry *e, size_t count, int dim, int bits)
{
    pbw__box box;
    size_t i, end;
    int deepest = 0;
    pbw__box_reset(&box, bits);
    for (i = 0; i < count; i++) {
        pbw__box_add(&box, e[i].x, dim);
    }
    pbw__box_close(&box, dim);
    if (box.extent == 0) {
        qsort(e, count, sizeof *e, by_place);
        return 0;
    }
    for (i = 0; i < count; i++) {
        e[i].key = pbw__hilbert_key(curve->step, &box, e[i].x, dim, curve->levels);
    }
    qsort(e, count, sizeof *e, by_key);
    for (i = 0; i < count; i = end) {
        for (end = i + 1; end < count && e[end].key == e[i].key; end++) {
        }
        if (end - i <= 12) {
            qsort(e + i, end - i, sizeof *e, by_place);
        } else {
            int depth = sort_entries(curve, e + i, end - i, dim, bits);
            deepest = depth > deepest ? depth : deepest;
        }
    }
    return deepest + 1;
}

/* Compares the vertices with the definition; returns how deep grids lie in grids. */
static int compare(const points *p)
{
    static const int threads[] = { 1, 2, 5, 16 };
    entry *e = (entry *)calloc(p->count, sizeof *e);
    pbw_index *canonical = (pbw_index *)calloc(p->count, sizeof *canonical);
    pbw__curve curve;
    size_t i, unique = 0;
    int index_bits = 1, bits, depth, k;
    if (e == NULL || canonical == NULL) {
        abort();
    }
    while ((p->count - 1) >> index_bits != 0) {
        index_bits++;
    }
    bits = index_bits > 10 ? index_bits : 10;
    bits = bits < (64 - index_bits) / p->dim ? bits : (64 - index_bits) / p->dim;
    pbw__curve_create(&curve, 1, p->dim);            /* bit by bit */
    for (i = 0; i < p->count; i++) {
        for (k = 0; k < p->dim; k++) {
            e[i].x[k] = p->x[i * (size_t)p->dim + (size_t)k] + 0.0;
        }
        e[i].x[3] = p->w != NULL ? p->w[i] : 0;
        e[i].index = i;
    }
    depth = sort_entries(&curve, e, p->count, p->dim, bits);
    for (i = 0; i < p->count; i++) {                 /* equal points follow each other */
        if (unique == 0 || memcmp(e[unique - 1].x, e[i].x, 3 * sizeof(double)) != 0) {
            e[unique++] = e[i];
        }
        canonical[e[i].index] = (pbw_index)e[unique - 1].index;
    }
    for (k = 0; k < 4; k++) {
        pbw_options options;
        pbw__context context;
        pbw__input input;
        pbw__vertices vertices;
        size_t wrong = 0;
        memset(&options, 0, sizeof options);
        memset(&input, 0, sizeof input);
        options.threads = threads[k];
        input.dim = p->dim;
        input.count = p->count;
        input.points = (const char *)p->x;
        input.weights = (const char *)p->w;
        input.stride = (size_t)p->dim * sizeof(double);
        input.weight_stride = sizeof(double);
        pbw__context_start(&context, &options, p->count);
        if (CHECK_EQUAL(pbw__order(&context, &input, &vertices), PBW_OK)) {
            CHECK_EQUAL(vertices.count, unique);
            CHECK_EQUAL(vertices.width, (size_t)p->dim + (p->w != NULL));
            CHECK_EQUAL(vertices.duplicate_count, p->count - unique);
            for (i = 0; i < unique && vertices.count == unique; i++) {
                const double *record = vertices.record + (i + 1) * vertices.width;
                wrong += vertices.id[i + 1] != e[i].index || (p->w != NULL && record[p->dim] != e[i].x[3])
                      || memcmp(record, e[i].x, (size_t)p->dim * sizeof(double)) != 0;
            }
            CHECK_EQUAL(wrong, 0);
            CHECK_EQUAL(pbw__make_canonical(&context, &vertices, NULL), PBW_OK);
            CHECK(memcmp(vertices.canonical, canonical, p->count * sizeof *canonical) == 0);
            pbw__vertices_free(&context, &vertices);
        }
        pbw__team_stop(&context);
        CHECK_EQUAL(context.memory.used, 0);
    }
    free(e);
    free(canonical);
    return depth;
}

static void test_kinds(void)
{
    int dim, kind;
    size_t i;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            size_t count;
            for (count = 1; count <= 20000; count = count * 5 + (count & 1)) {
                if (test_begin("%dD %s, %lu points", dim, input_name(kind), (unsigned long)count)) {
                    points p = points_create(dim, count);
                    input_fill(kind, dim, count, test_seed, p.x);
                    compare(&p);
                    points_destroy(&p);
                    test_end();
                }
            }
        }
        if (test_begin("%dD, each point many times, zeros of both signs, weights", dim)) {
            points p = points_create(dim, 5000);
            uint64_t state = test_seed;
            p.w = (double *)calloc(p.count, sizeof(double));
            for (i = 0; i < p.count && p.w != NULL; i++) {
                size_t k;
                for (k = 0; k < (size_t)dim; k++) {
                    p.x[i * (size_t)dim + k] = (double)input_below(&state, 5) / 8 * (i % 2 == 0 ? 1 : -1);
                }
                p.w[i] = (double)input_below(&state, 3);
            }
            compare(&p);
            points_destroy(&p);
            test_end();
        }
    }
}

/* Keys are made by eights, and few points are sorted by other bits than many. */
static void test_counts(void)
{
    static const size_t limits[] = { 0, 64, 128, 256, 512, 1024, 3000, 8192 };
    int dim, kind;
    size_t i, count;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < 3; kind++) {
            const int input = kind == 0 ? INPUT_UNIFORM : kind == 1 ? INPUT_CLUSTERS : INPUT_LATTICE;
            for (i = 0; i < sizeof limits / sizeof limits[0]; i++) {
                if (test_begin("%dD %s, about %lu points", dim, input_name(input), (unsigned long)limits[i])) {
                    for (count = i > 0 ? limits[i] - 2 : 1; count <= limits[i] + (i > 0 ? 2 : 33); count++) {
                        points p = points_create(dim, count);
                        input_fill(input, dim, count, test_seed, p.x);
                        compare(&p);
                        points_destroy(&p);
                    }
                    test_end();
                }
            }
        }
    }
}

/* Some points at each of many scales: nearly all points lie in one cell of each grid but the last. */
static void test_scales(void)
{
    static const int shifts[] = { 3, 10, 16, 40 }, counts[] = { 1, 13, 1000 };
    int dim, i, j;
    for (dim = 2; dim <= 3; dim++) {
        for (i = 0; i < 4; i++) {
            for (j = 0; j < 3; j++) {
                int shift = shifts[i], each = counts[j];
                if (test_begin("%dD, %d points at each scale, 2^%d apart", dim, each, shift)) {
                    const int scales = 2000 / shift * each <= 20000 ? 2000 / shift : 20000 / each;
                    points p = points_create(dim, (size_t)(scales * each));
                    uint64_t state = test_seed;
                    size_t k;
                    for (k = 0; k < p.count * (size_t)dim; k++) {
                        int exponent = 1000 - (int)(k / (size_t)(dim * each)) * shift;
                        p.x[k] = ldexp(input_uniform(&state) - (k % 2 == 0), exponent);
                    }
                    input_shuffle(dim, p.count, &state, p.x);
                    CHECK(compare(&p) < PBW__RUN_DEPTH);
                    points_destroy(&p);
                    test_end();
                }
            }
        }
        if (test_begin("%dD, grids in grids as deep as can be", dim)) {
            points p = points_create(dim, 230);      /* 10 bits a grid, whose first cell holds all but one point */
            size_t k;
            int depth;
            for (k = 0; k < p.count; k++) {
                p.x[k * (size_t)dim + k % (size_t)dim] = k < 208 ? ldexp(1.9 - (double)k / 1000, 1023 - 10 * (int)k)
                                                       : ldexp((double)(k - 208), -1074);
            }
            p.x[1] = -0.9 * p.x[0];                  /* wider than the largest double */
            depth = compare(&p);
            CHECK(depth > 200 && depth < PBW__RUN_DEPTH);
            points_destroy(&p);
            test_end();
        }
    }
}

/* Runs as long as the input: one point far away, so that all others lie in one cell; points at one place. */
static void test_runs(void)
{
    static const char *const names[] = {
        "a point far away", "a cluster far from a place", "one place", "most at one place"
    };
    int dim, kind;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < 4; kind++) {
            size_t count;
            for (count = 2; count <= 40000; count = count * 4 + 1) {
                if (test_begin("%dD, %s, %lu points", dim, names[kind], (unsigned long)count)) {
                    points p = points_create(dim, count);
                    uint64_t state = test_seed;
                    size_t i;
                    input_fill(INPUT_UNIFORM, dim, count, test_seed, p.x);
                    for (i = 0; i < count * (size_t)dim; i++) {
                        p.x[i] = kind == 0 ? p.x[i] + 1 : kind == 1 ? (i / (size_t)dim % 2 ? 1e-300 * p.x[i] : 1e300)
                               : kind == 2 ? 7.0 : input_below(&state, 10) > 0 ? 0.25 : p.x[i];
                    }
                    p.x[count / 2 * (size_t)dim] = kind == 0 ? 1e300 : p.x[count / 2 * (size_t)dim];
                    compare(&p);
                    points_destroy(&p);
                    test_end();
                }
            }
        }
    }
}

/* Points of one cell of the curve's grid are one thread's, unless they are many: a run of two and a half shares must
   not keep what follows from being cut. */
static void test_cut(void)
{
    enum { COUNT = 6400, TASKS = 4, SHARE = COUNT / (4 * TASKS), FROM = 700, TO = 1700, BITS = 13 };
    if (test_begin("parts: a run of more than two shares")) {
        static uint64_t keys[COUNT];
        pbw__part part[PBW__CUTS * TASKS];
        static pbw__ordering ordering;
        pbw__input input;
        size_t end = 0, i;
        int parts, p, runs = 0;
        memset(part, 0, sizeof(part));
        memset(&input, 0, sizeof(input));
        for (i = 0; i < COUNT; i++) {
            keys[i] = (uint64_t)(i >= FROM && i < TO ? FROM : i) << BITS | i;
        }
        input.count = COUNT;
        ordering.input = &input;
        ordering.keys = keys;
        ordering.parts = part;
        ordering.index_bits = BITS;
        part[0].to = COUNT;
        part[0].low = BITS;
        ordering.tasks = TASKS;
        parts = pbw__order_cut(&ordering);
        for (p = 0; p < parts; p++) {
            const int run = part[p].from == FROM && part[p].to == TO;
            CHECK(part[p].from == end && (run || part[p].to - part[p].from <= 2 * SHARE));
            end = part[p].to;
            runs += run;
        }
        CHECK(end == COUNT && runs == 1);
        test_end();
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 1);
    test_kinds();
    test_counts();
    test_scales();
    test_runs();
    test_cut();
    return test_finish();
}
