/* test_live.c: triangulations that live.  After each commit of random insertions, removals and moves the view is
   compared, byte for byte, with a fresh build of the points that live, and the changes with the sets of simplices
   before and after. */
#include "pbw_check.h"
#include "pbw_live.h"
#include "meshes.h"
#include "meter.h"
#include "test.h"
#include <math.h>
#if defined(__unix__) || defined(__APPLE__)
#include <sys/wait.h>
#include <unistd.h>
#endif

#ifndef CHOOSE_WAY                                      /* see test_live_local.c */
#define CHOOSE_WAY(turn) ((void)(turn))
#define THREADS 1
#endif

/* What a live triangulation should hold: points by number. */
typedef struct model {
    int dim, weighted;
    size_t count, room;
    double *points, *weights;
    unsigned char *lives;
    uint64_t state;
} model;

static void model_start(model *m, int dim, uint64_t seed)
{
    memset(m, 0, sizeof *m);
    m->dim = dim;
    m->state = seed;
}

static void model_room(model *m, size_t count)
{
    if (count > m->room) {
        m->room = 2 * count + 64;
        m->points = (double *)zoo_grow(m->points, m->room * 3 * sizeof(double));
        m->weights = (double *)zoo_grow(m->weights, m->room * sizeof(double));
        m->lives = (unsigned char *)zoo_grow(m->lives, m->room);
    }
    for (; m->count < count; m->count++) {
        memset(m->points + 3 * m->count, 0, 3 * sizeof(double));
        m->weights[m->count] = 0;
        m->lives[m->count] = 0;
    }
}

static void model_free(model *m)
{
    free(m->points);
    free(m->weights);
    free(m->lives);
}

static size_t model_alive(const model *m)
{
    size_t i, n = 0;
    for (i = 0; i < m->count; i++) {
        n += m->lives[i];
    }
    return n;
}

/* A number that lives, or PBW_NONE. */
static pbw_index model_pick(model *m)
{
    int tries;
    for (tries = 0; tries < 64 && m->count > 0; tries++) {
        const pbw_index i = input_below(&m->state, (uint32_t)m->count);
        if (m->lives[i]) {
            return i;
        }
    }
    return PBW_NONE;
}

/* The kinds of sets: coordinates and weights from the state. */
enum { UNIFORM, LATTICE, CLUSTERS, LINES, SPHERE, FLAT, KINDS };
static const char *const kind_name[KINDS] = { "uniform", "lattice", "clusters", "lines", "sphere", "flat" };

static void model_point(model *m, int kind, double *p)
{
    int k;
    for (k = 0; k < m->dim; k++) {
        const double u = input_uniform(&m->state);
        switch (kind) {
        case LATTICE: p[k] = (double)input_below(&m->state, m->dim == 2 ? 12 : 6); break;
        case CLUSTERS: p[k] = (double)input_below(&m->state, 3) + u * u * u * 1e-3; break;
        case LINES: p[k] = k == 0 ? floor(u * 50) : (double)input_below(&m->state, 2) * (u < 0.9 ? 1 : u); break;
        case FLAT: p[k] = k + 1 < m->dim ? floor(u * 8) : (u < 0.03 ? 1 : 0); break;
        default: p[k] = u;
        }
    }
    if (kind == SPHERE) {                               /* exactly cospherical: signed permutations of few vectors */
        static const double of[3] = { 3, 4, 12 };
        const uint32_t turn = input_below(&m->state, (uint32_t)m->dim), signs = input_below(&m->state, 8);
        for (k = 0; k < m->dim; k++) {
            p[k] = of[((uint32_t)k + turn) % (uint32_t)m->dim] * ((signs >> k & 1) != 0 ? 1 : -1);
        }
        if (input_below(&m->state, 4) == 0) {
            p[0] = 0;
        }
    }
}

static double model_weight(model *m, int kind)
{
    return kind == LATTICE || kind == FLAT ? (double)input_below(&m->state, 4) : 0.02 * input_uniform(&m->state);
}

/* One random change, queued; 1 if it was taken. */
static int model_change(model *m, pbw_live *live, int kind, int what)
{
    pbw_index id = PBW_NONE;
    double p[3] = { 0, 0, 0 }, w;
    pbw_status status;
    if (what == 0) {
        model_point(m, kind, p);
        w = m->weighted ? model_weight(m, kind) : 0;
        status = pbw_live_insert(live, p, m->weighted ? &w : NULL, 1, &id);
        if (CHECK_EQUAL(status, PBW_OK)) {
            model_room(m, (size_t)id + 1);
            CHECK(!m->lives[id]);
            m->lives[id] = 1;
            memcpy(m->points + 3 * id, p, sizeof p);
            m->weights[id] = w;
        }
        return status == PBW_OK;
    }
    id = model_pick(m);
    if (id == PBW_NONE) {
        return 0;
    }
    if (what == 1) {
        m->lives[id] = 0;
        memset(m->points + 3 * id, 0, 3 * sizeof(double));
        m->weights[id] = 0;
        return CHECK_EQUAL(pbw_live_remove(live, &id, 1), PBW_OK);
    }
    model_point(m, kind, p);
    if (what == 3) {                                    /* a short way */
        int k;
        for (k = 0; k < m->dim; k++) {
            p[k] = m->points[3 * id + (size_t)k] + 0.05 * (p[k] - m->points[3 * id + (size_t)k]);
        }
    }
    memcpy(m->points + 3 * id, p, sizeof p);
    return CHECK_EQUAL(pbw_live_move(live, &id, p, 1), PBW_OK);
}

/* All points move: by steps of `size` of the way to random places. */
static void model_move_all(model *m, pbw_live *live, int kind, double size)
{
    const size_t dim = (size_t)m->dim;
    double *points = (double *)zoo_grow(NULL, (m->count * dim + 1) * sizeof(double));
    size_t i, k;
    for (i = 0; i < m->count; i++) {
        double p[3] = { 0, 0, 0 };
        model_point(m, kind, p);
        for (k = 0; k < dim; k++) {
            points[i * dim + k] = m->points[3 * i + k] + size * (p[k] - m->points[3 * i + k]);
            m->points[3 * i + k] = m->lives[i] ? points[i * dim + k] : 0;
        }
    }
    CHECK_EQUAL(pbw_live_move(live, NULL, points, m->count), PBW_OK);
    free(points);
}

/* The mesh that the view should be: of the points that live, in numbers. */
static pbw_status model_mesh(const model *m, pbw_mesh *mesh, pbw_index **ids)
{
    const size_t dim = (size_t)m->dim, n = model_alive(m);
    double *points = (double *)zoo_grow(NULL, (n * dim + 1) * sizeof(double));
    double *weights = (double *)zoo_grow(NULL, (n + 1) * sizeof(double));
    pbw_options options;
    size_t i, at = 0;
    pbw_status status;
    *ids = (pbw_index *)zoo_grow(NULL, (n + 1) * sizeof(pbw_index));
    for (i = 0; i < m->count; i++) {
        if (m->lives[i]) {
            memcpy(points + at * dim, m->points + 3 * i, dim * sizeof(double));
            weights[at] = m->weights[i];
            (*ids)[at++] = (pbw_index)i;
        }
    }
    memset(&options, 0, sizeof options);
    options.threads = 1;
    status = pbw_triangulate(m->dim, points, m->weighted ? weights : NULL, n, &options, mesh);
    free(points);
    free(weights);
    return status;
}

/* Is the view that of the model? */
static int model_agrees(const model *m, pbw_live *live)
{
    const size_t dim = (size_t)m->dim;
    pbw_mesh fresh, view;
    pbw_index *ids;
    const char *fault;
    const pbw_status status = model_mesh(m, &fresh, &ids);
    size_t i, n = fresh.point_count, bad = 0, live_count = 0;
    if (!CHECK_EQUAL(pbw_live_view(live, &view), status) || !CHECK_EQUAL(view.simplex_count, fresh.simplex_count)
        || !CHECK(view.point_count >= m->count)) {
        free(ids);
        pbw_free(&fresh);
        pbw_free(&view);
        return 0;
    }
    for (i = 0; i < fresh.simplex_count * (dim + 1); i++) {
        bad += view.simplices[i] != ids[fresh.simplices[i]] || view.neighbors[i] != fresh.neighbors[i];
    }
    for (i = 0; i < n; i++) {
        bad += view.incident[ids[i]] != fresh.incident[i] || view.canonical[ids[i]] != ids[fresh.canonical[i]];
        bad += memcmp(view.points + dim * ids[i], fresh.points + dim * i, dim * sizeof(double)) != 0;
        bad += (view.weights != NULL) != (fresh.weights != NULL);
        bad += view.weights != NULL && fresh.weights != NULL && view.weights[ids[i]] != fresh.weights[i];
    }
    for (i = 0; i < view.point_count; i++) {
        live_count += view.canonical[i] != PBW_NONE;
        bad += view.canonical[i] == PBW_NONE && view.incident[i] != PBW_NONE;
    }
    bad += live_count != n || view.duplicate_count != fresh.duplicate_count
         || view.hidden_count != fresh.hidden_count || pbw_hash(&view, NULL) != pbw_hash(&fresh, NULL);
    fault = meshes_fault(&view);
    if (!CHECK(fault == NULL)) {
        test_say("%s", fault);
    }
    free(ids);
    pbw_free(&fresh);
    pbw_free(&view);
    return CHECK_EQUAL(bad, 0) && fault == NULL;
}

/* ---- changes against the simplices before and after */
static int tuple_width;
static int tuple_compare(const void *a, const void *b)
{
    const pbw_index *x = (const pbw_index *)a, *y = (const pbw_index *)b;
    int k;
    for (k = 0; k + 1 < tuple_width && x[k] == y[k]; k++) {
    }
    return (x[k] > y[k]) - (x[k] < y[k]);
}

/* The simplices of a mesh, each by an even permutation in ascending order but for the last two corners; in order. */
static pbw_index *sets_of(const pbw_index *simplices, size_t count, int dim)
{
    const size_t corners = (size_t)dim + 1;
    pbw_index *sets = (pbw_index *)zoo_grow(NULL, (count * corners + 1) * sizeof(pbw_index));
    size_t i, j, k;
    for (i = 0; i < count; i++) {
        pbw_index *v = sets + i * corners, last;
        int odd = 0;
        for (k = 0; k < corners; k++) {
            const pbw_index x = simplices[i * corners + k];
            for (j = k; j > 0 && v[j - 1] > x; j--) {
                v[j] = v[j - 1];
                odd ^= 1;
            }
            v[j] = x;
        }
        last = v[corners - 1];
        if (odd) {
            v[corners - 1] = v[corners - 2];
            v[corners - 2] = last;
        }
    }
    tuple_width = (int)corners;
    qsort(sets, count, corners * sizeof(pbw_index), tuple_compare);
    return sets;
}

static size_t sets_in_common(const pbw_index *a, size_t n, const pbw_index *b, size_t m, int dim)
{
    const size_t corners = (size_t)dim + 1;
    size_t i = 0, j = 0, common = 0;
    while (i < n && j < m) {
        const int order = tuple_compare(a + i * corners, b + j * corners);
        common += order == 0;
        i += order <= 0;
        j += order >= 0;
    }
    return common;
}

/* Does `changes` lead from one mesh to the other? */
static void check_changes(const pbw_mesh *before, const pbw_mesh *after, const pbw_changes *changes)
{
    const int dim = after->dim;
    const size_t n = before->simplex_count, m = after->simplex_count, corners = (size_t)dim + 1;
    pbw_index *a = sets_of(before->simplices, n, dim), *b = sets_of(after->simplices, m, dim);
    pbw_index *deleted = sets_of(changes->deleted, changes->deleted_count, dim);
    pbw_index *made = sets_of(changes->made, changes->made_count, dim);
    unsigned char *seen = (unsigned char *)zoo_grow(NULL, after->point_count + before->point_count + 1);
    size_t common = sets_in_common(a, n, b, m, dim), i, points = 0;
    memset(seen, 0, after->point_count + before->point_count + 1);
    CHECK_EQUAL(changes->deleted_count, n - common);
    CHECK_EQUAL(changes->made_count, m - common);
    CHECK_EQUAL(sets_in_common(deleted, changes->deleted_count, a, n, dim), changes->deleted_count);
    CHECK_EQUAL(sets_in_common(deleted, changes->deleted_count, b, m, dim), 0);
    CHECK_EQUAL(sets_in_common(made, changes->made_count, b, m, dim), changes->made_count);
    for (i = 0; i < changes->deleted_count * corners; i++) {
        seen[deleted[i]] = 1;
    }
    for (i = 0; i < changes->made_count * corners; i++) {
        seen[made[i]] = 1;
    }
    for (i = 0; i < after->point_count; i++) {
        points += seen[i];
    }
    CHECK_EQUAL(changes->point_count, points);
    for (i = 0; i < changes->point_count; i++) {
        CHECK(seen[changes->points[i]] && (i == 0 || changes->points[i - 1] < changes->points[i]));
    }
    free(a);
    free(b);
    free(deleted);
    free(made);
    free(seen);
}

/* ---- random sequences */
static long ways[4];                                    /* how often each was taken */

static void sequence(int dim, int kind, int weighted, int threads, int commits, int most)
{
    pbw_options options;
    pbw_live *live = NULL;
    pbw_mesh before;
    model m;
    int c;
    memset(&options, 0, sizeof options);
    memset(&before, 0, sizeof before);
    options.threads = threads;
    before.dim = dim;
    model_start(&m, dim, test_seed * 1000 + (uint64_t)(dim * 100 + kind * 10 + weighted));
    m.weighted = weighted;
    CHECK_EQUAL(pbw_live_create(&before, &options, &live), PBW_DEGENERATE);
    for (c = 0; c < commits && test_faults == 0; c++) {
        const int grow = model_alive(&m) < (size_t)most ? 3 : 1, mode = (int)input_below(&m.state, 10);
        int ops = 1 + (int)input_below(&m.state, c % 7 == 0 ? (uint32_t)most / 2 + 1 : 6);
        pbw_changes changes;
        pbw_mesh after;
        pbw_status status;
        CHOOSE_WAY(c);
        for (; ops > 0; ops--) {
            const int dice = (int)input_below(&m.state, 8);
            (void)model_change(&m, live, kind, mode == 0 ? 1 : mode == 1 ? 3 : dice < grow ? 0 : dice < 4 ? 1
                                               : dice < 6 ? 2 : 3);
        }
        if (mode == 2 && input_below(&m.state, 4) == 0) {       /* all go */
            while (model_alive(&m) > 0) {
                (void)model_change(&m, live, kind, 1);
            }
        }
        if (mode >= 8 && m.count > 0) {
            static const double size[5] = { 1e-12, 1e-4, 0.003, 0.03, 1 };
            CHECK(pbw_live_commit(live, NULL) <= PBW_DEGENERATE);
            pbw_free(&before);
            CHECK(pbw_live_view(live, &before) <= PBW_DEGENERATE);
            model_move_all(&m, live, kind, size[input_below(&m.state, 5)]);
        }
        status = pbw_live_commit(live, &changes);
        CHECK(status == PBW_OK || status == PBW_DEGENERATE);
        if (!model_agrees(&m, live)) {
            test_say("commit %d of %s in %dD%s", c, kind_name[kind], dim, weighted ? ", weighted" : "");
        }
        CHECK(pbw_live_view(live, &after) == status);
        check_changes(&before, &after, &changes);
        ways[changes.way]++;
        pbw_changes_free(&changes);
        pbw_free(&before);
        before = after;
    }
    pbw_free(&before);
    pbw_live_free(live);
    model_free(&m);
}

static void test_sequences(void)
{
    int dim, kind, weighted, commits = (int)(test_count > 400 ? 400 + (test_count - 400) / 20 : test_count);
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < KINDS; kind++) {
            for (weighted = 0; weighted < 2; weighted++) {
                if (test_begin("sequence: %dD %s%s", dim, kind_name[kind], weighted ? ", weighted" : "")) {
                    sequence(dim, kind, weighted, 1, commits, 12);
                    sequence(dim, kind, weighted, THREADS, commits / 2, 150);
                    sequence(dim, kind, weighted, 3, commits / 8, 150);
                    test_end();
                }
            }
        }
    }
}

/* ---- all or nothing */
static pbw_options metered(meter *m)
{
    pbw_options options;
    memset(&options, 0, sizeof options);
    options.threads = THREADS;
    options.resize = meter_resize;
    options.resize_user = m;
    return options;
}

/* A commit of all kinds of changes with the k-th request refused, for every k: it fails and leaves everything as it
   was, and the next one carries it out.  Where threads are watched for races, which takes twenty times as long, every
   seventh k is enough in space: what is lost in memory the other runs find. */
static void refuse(int dim, int kind, int weighted, int moves, int fail_all_after)
{
    long k;
    for (k = 1; k < 3000 && test_faults == 0; k += TEST_WATCHES_THREADS && dim == 3 ? 7 : 1) {
        pbw_mesh none;
        pbw_options options;
        pbw_live *live = NULL;
        pbw_changes changes;
        model m, old;
        meter allocator;
        pbw_status status;
        long refused;
        int i;
        memset(&none, 0, sizeof none);
        none.dim = dim;
        meter_start(&allocator, 0, fail_all_after);
        options = metered(&allocator);
        model_start(&m, dim, 77);
        m.weighted = weighted;
        CHECK_EQUAL(pbw_live_create(&none, &options, &live), PBW_DEGENERATE);
        for (i = 0; i < 40; i++) {
            (void)model_change(&m, live, kind, 0);
        }
        CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
        model_start(&old, dim, 0);
        old.weighted = weighted;
        model_room(&old, m.count);
        memcpy(old.points, m.points, m.count * 3 * sizeof(double));
        memcpy(old.weights, m.weights, m.count * sizeof(double));
        memcpy(old.lives, m.lives, m.count);
        for (i = 0; i < 12; i++) {
            (void)model_change(&m, live, kind, moves ? 2 + i % 2 : i % 4);
        }
        allocator.fail_at = allocator.requests + k;
        status = pbw_live_commit(live, &changes);
        refused = allocator.refused;
        allocator.fail_at = 0;
        allocator.fail_all_after = 0;
        if (status != PBW_OK) {
            CHECK_EQUAL(status, PBW_ERROR_MEMORY);
            CHECK(refused > 0 && changes.memory == NULL);
            CHECK(model_agrees(&old, live));
            CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
        } else {
            pbw_changes_free(&changes);
        }
        CHECK(model_agrees(&m, live));
        pbw_live_free(live);
        model_free(&m);
        model_free(&old);
        CHECK_EQUAL(allocator.blocks, 0);
        CHECK_EQUAL(allocator.faults, 0);
        if (test_faults > 0) {
            test_say("%dD %s, request %ld", dim, kind_name[kind], k);
        }
        if (refused == 0) {
            return;
        }
    }
    CHECK(test_faults > 0);
}

static void test_refusals(void)
{
    int dim, weighted, turn;
    for (dim = 2; dim <= 3; dim++) {
        for (weighted = 0; weighted < 2; weighted++) {
            if (test_begin("every allocation fails: %dD%s", dim, weighted ? ", weighted" : "")) {
                for (turn = 0; turn < 2; turn++) {
                    CHOOSE_WAY(turn);
                    refuse(dim, UNIFORM, weighted, turn, 0);
                    refuse(dim, LATTICE, weighted, 0, 1);
                    refuse(dim, CLUSTERS, weighted, 1, turn);
                }
                test_end();
            }
        }
    }
}

typedef struct stopper { long calls, stop_at; } stopper;

static int stop(void *user, pbw_stage stage, double done)
{
    stopper *s = (stopper *)user;
    (void)stage;
    (void)done;
    return ++s->calls == s->stop_at;
}

static void test_cancel(void)
{
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("cancelled: %dD", dim)) {
            long k, cancelled = 0, finished = 0;
            for (k = 1; k < 200 && finished < 4; k++) {
                stopper s = { 0, 0 };
                pbw_options options;
                pbw_live *live;
                pbw_mesh none, before, after;
                model m;
                int i;
                memset(&options, 0, sizeof options);
                memset(&none, 0, sizeof none);
                none.dim = dim;
                options.threads = THREADS;
                options.progress = stop;
                options.progress_user = &s;
                model_start(&m, dim, 5);
                CHECK_EQUAL(pbw_live_create(&none, &options, &live), PBW_DEGENERATE);
                for (i = 0; i < 300; i++) {
                    (void)model_change(&m, live, UNIFORM, 0);
                }
                CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
                CHECK_EQUAL(pbw_live_view(live, &before), PBW_OK);
                CHOOSE_WAY(k >> 1);
                for (i = 0; i < 20; i++) {
                    (void)model_change(&m, live, UNIFORM, (k & 1) != 0 ? i % 4 : 2 + i % 2);
                }
                s.stop_at = s.calls + k;
                if (pbw_live_commit(live, NULL) == PBW_CANCELLED) {
                    cancelled++;
                    s.stop_at = 0;
                    CHECK_EQUAL(pbw_live_view(live, &after), PBW_OK);
                    CHECK(meshes_equal(&before, &after));
                    pbw_free(&after);
                    CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
                } else {
                    finished++;
                }
                s.stop_at = 0;
                CHECK(model_agrees(&m, live));
                pbw_free(&before);
                pbw_live_free(live);
                model_free(&m);
            }
            CHECK(cancelled > 0);
            test_end();
        }
    }
}

/* ---- memory: what the allocator holds after many operations on so many points, of what it held before */
static void test_memory(void)
{
    int dim;
    for (dim = 2; dim <= 3; dim++) {
        if (test_begin("memory: %dD", dim)) {
            const size_t n = 2000;
            const long rounds = test_count > 5000 ? 10000 : test_count > 1000 ? 300 : 60;    /* of 100 operations */
            double points[300];
            pbw_index *ids = (pbw_index *)zoo_grow(NULL, n * sizeof(pbw_index));
            pbw_options options;
            pbw_live *live;
            pbw_mesh none;
            meter allocator;
            model m;
            size_t before, i, k;
            long round;
            memset(&none, 0, sizeof none);
            none.dim = dim;
            meter_start(&allocator, 0, 0);
            options = metered(&allocator);
            model_start(&m, dim, 3);
            CHECK_EQUAL(pbw_live_create(&none, &options, &live), PBW_DEGENERATE);
            for (i = 0; i < n; i++) {
                model_point(&m, UNIFORM, points);
                CHECK_EQUAL(pbw_live_insert(live, points, NULL, 1, ids + i), PBW_OK);
            }
            CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
            for (round = 0, before = 0; round < rounds + 30; round++) {
                const size_t first = input_below(&m.state, (uint32_t)n - 50);
                before = round == 30 ? allocator.bytes : before;
                CHECK_EQUAL(pbw_live_remove(live, ids + first, 50), PBW_OK);
                for (k = 0; k < 50; k++) {
                    model_point(&m, UNIFORM, points + k * (size_t)dim);
                }
                CHECK_EQUAL(pbw_live_insert(live, points, NULL, 50, ids + first), PBW_OK);
                CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
            }
            test_say("%ld operations, %.1f bytes a point, then %.1f", 100 * rounds, (double)before / (double)n,
                     (double)allocator.bytes / (double)n);
            CHECK((double)allocator.bytes <= 1.1 * (double)before);
            pbw_live_free(live);
            CHECK_EQUAL(allocator.blocks, 0);
            free(ids);
            model_free(&m);
            test_end();
        }
    }
}

/* ---- from a mesh: of any flags, and of arrays that are wrong
   Does a live triangulation made of this mesh hold the model, and still after some changes? */
static int note_build(void *user, pbw_stage stage, double done)
{
    (void)done;
    *(int *)user |= stage == PBW_STAGE_BUILD;
    return 0;
}

static void check_from_mesh(const pbw_mesh *mesh, model *m, int kind, int threads)
{
    pbw_options options;
    pbw_live *live;
    int i, built = 0;
    memset(&options, 0, sizeof options);
    options.threads = threads;
    options.progress = note_build;
    options.progress_user = &built;
    if (CHECK(pbw_live_create(mesh, &options, &live) <= PBW_DEGENERATE) && CHECK(model_agrees(m, live))) {
        CHECK(built);
        for (i = 0; i < 6; i++) {
            (void)model_change(m, live, kind, i % 4);
        }
        CHECK(pbw_live_commit(live, NULL) <= PBW_DEGENERATE);
        CHECK(model_agrees(m, live));
    }
    pbw_live_free(live);
}

static void model_copy(model *to, const model *from)
{
    model_start(to, from->dim, from->state);
    to->weighted = from->weighted;
    model_room(to, from->count);
    memcpy(to->points, from->points, from->count * 3 * sizeof(double));
    memcpy(to->weights, from->weights, from->count * sizeof(double));
    memcpy(to->lives, from->lives, from->count);
}

/* A model of random points, numbered as in the mesh, and their mesh with these flags. */
static pbw_status model_random(model *m, int kind, size_t count, unsigned flags, double **points, pbw_mesh *mesh)
{
    const size_t dim = (size_t)m->dim;
    pbw_options options;
    pbw_status status;
    size_t i;
    memset(&options, 0, sizeof options);
    options.flags = flags;
    options.threads = 1;
    model_room(m, count);
    *points = (double *)zoo_grow(NULL, (count * dim + 1) * sizeof(double));
    for (i = 0; i < count; i++) {
        m->lives[i] = 1;
        model_point(m, kind, m->points + 3 * i);
        memcpy(*points + i * dim, m->points + 3 * i, dim * sizeof(double));
        m->weights[i] = m->weighted ? model_weight(m, kind) : 0;
    }
    status = pbw_triangulate(m->dim, *points, m->weighted ? m->weights : NULL, count, &options, mesh);
    for (i = 0; i < count && CHECK(status <= PBW_DEGENERATE); i++) {
        memcpy(m->points + 3 * i, mesh->points + dim * i, dim * sizeof(double));
        m->weights[i] = mesh->weights != NULL ? mesh->weights[i] : 0;
    }
    return status;
}

static void test_from_mesh(void)
{
    static const unsigned flags[5] = { 0, PBW_NO_NEIGHBORS, PBW_ANY_ORDER, PBW_CURVE_ORDER, PBW_BORROW };
    int dim, kind, weighted, i;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < KINDS; kind++) {
            if (!test_begin("from a mesh: %dD %s", dim, kind_name[kind])) {
                continue;
            }
            for (weighted = 0; weighted < 2; weighted++) {
                for (i = 0; i < 5; i++) {
                    static const size_t counts[4] = { 5, 40, 300, 3000 };
                    const size_t count = counts[i == 0 ? 3 : (size_t)i % 3];
                    model m;
                    pbw_mesh mesh;
                    double *points;
                    model_start(&m, dim, test_seed * 31 + (uint64_t)(100 * kind + 10 * i + weighted));
                    m.weighted = weighted;
                    (void)model_random(&m, kind, count, flags[i], &points, &mesh);
                    check_from_mesh(&mesh, &m, kind, 1 + 2 * (i % 3));
                    pbw_free(&mesh);
                    free(points);
                    model_free(&m);
                }
            }
            test_end();
        }
    }
}

/* The same arrays by any number of threads: at first, after all points moved a little, and after a batch. */
static void test_thread_counts(void)
{
    static const int threads[3] = { 1, 2, 5 };
    int dim, i, weighted;
    for (dim = 2; dim <= 3; dim++) {
        for (weighted = 0; weighted < 2; weighted++) {
            pbw_mesh mesh, view[3][3];
            double *points;
            model m;
            if (!test_begin("threads: %dD%s", dim, weighted ? ", weighted" : "")) {
                continue;
            }
            model_start(&m, dim, 11);
            m.weighted = weighted;
            CHECK_EQUAL(model_random(&m, UNIFORM, dim == 2 ? 20000 : 6000, 0, &points, &mesh), PBW_OK);
            memset(view, 0, sizeof view);
            for (i = 0; i < 3; i++) {
                pbw_options options;
                pbw_live *live;
                model all;
                int c;
                CHOOSE_WAY(1);
                model_copy(&all, &m);
                memset(&options, 0, sizeof options);
                options.threads = threads[i];
                CHECK_EQUAL(pbw_live_create(&mesh, &options, &live), PBW_OK);
                CHECK_EQUAL(pbw_live_view(live, &view[i][0]), PBW_OK);
                model_move_all(&all, live, UNIFORM, 1e-6);
                CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
                CHECK_EQUAL(pbw_live_view(live, &view[i][1]), PBW_OK);
                for (c = 0; c < 200; c++) {
                    (void)model_change(&all, live, UNIFORM, c % 4);
                }
                CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
                CHECK_EQUAL(pbw_live_view(live, &view[i][2]), PBW_OK);
                CHECK(i > 0 || model_agrees(&all, live));
                for (c = 0; c < 3; c++) {
                    CHECK(meshes_equal(&view[0][c], &view[i][c]));
                }
                pbw_live_free(live);
                model_free(&all);
            }
            for (i = 0; i < 9; i++) {
                pbw_free(&view[i / 3][i % 3]);
            }
            pbw_free(&mesh);
            free(points);
            model_free(&m);
            test_end();
        }
    }
}

/* Numbers in random order, by any number of threads: of two moves of a point the last one counts, two removals are
   refused and queue nothing. */
static void test_number_order(void)
{
    static const int threads[3] = { 1, 2, 5 };
    int dim, i;
    for (dim = 2; dim <= 3; dim++) {
        if (!test_begin("numbers in any order: %dD", dim)) {
            continue;
        }
        for (i = 0; i < 3; i++) {
            const size_t count = TEST_SIZE(dim == 2 ? 20000u : 6000u), some = count / 2, size = (size_t)dim;
            pbw_index *ids = (pbw_index *)zoo_grow(NULL, count * sizeof *ids);
            double *places;
            pbw_options options;
            pbw_live *live;
            pbw_mesh mesh;
            model m;
            size_t k, at;
            int turn;
            model_start(&m, dim, 31);
            CHECK_EQUAL(model_random(&m, UNIFORM, count, 0, &places, &mesh), PBW_OK);
            memset(&options, 0, sizeof options);
            options.threads = threads[i];
            CHECK_EQUAL(pbw_live_create(&mesh, &options, &live), PBW_OK);
            for (turn = 0; turn < 3; turn++) {       /* 1: some numbers occur twice */
                CHOOSE_WAY(turn);
                for (k = 0; k < count; k++) {
                    at = input_below(&m.state, (uint32_t)k + 1);
                    ids[k] = ids[at];
                    ids[at] = (pbw_index)k;
                }
                for (k = 0; k < some; k++) {
                    ids[k] = turn == 1 && k % 100 == 99 ? ids[input_below(&m.state, (uint32_t)k)] : ids[k];
                    model_point(&m, UNIFORM, m.points + 3 * ids[k]);
                    memcpy(places + k * size, m.points + 3 * ids[k], size * sizeof(double));
                }
                CHECK_EQUAL(pbw_live_move(live, ids, places, some), PBW_OK);
                CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
                CHECK(model_agrees(&m, live));
            }
            at = ids[3];
            ids[3] = ids[some - 5];
            CHECK_EQUAL(pbw_live_remove(live, ids, some), PBW_ERROR_ARGUMENT);
            ids[3] = (pbw_index)at;
            for (k = 0; k < some; k++) {
                m.lives[ids[k]] = 0;
            }
            CHECK_EQUAL(pbw_live_remove(live, ids, some), PBW_OK);
            CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
            CHECK(model_agrees(&m, live));
            pbw_live_free(live);
            pbw_free(&mesh);
            free(places);
            free(ids);
            model_free(&m);
        }
        test_end();
    }
}

/* A process that forks keeps its threads, and the fork starts its own. */
static void test_fork(void)
{
#if (defined(__unix__) || defined(__APPLE__)) && !TEST_WATCHES_THREADS
    pbw_options options;
    pbw_live *live;
    pbw_mesh mesh;
    double *points;
    pid_t child;
    model m;
    int i, status = 0;
    if (!test_begin("a fork")) {
        return;
    }
    model_start(&m, 2, 41);
    CHECK_EQUAL(model_random(&m, UNIFORM, 20000, 0, &points, &mesh), PBW_OK);
    memset(&options, 0, sizeof options);
    options.threads = 3;
    CHECK_EQUAL(pbw_live_create(&mesh, &options, &live), PBW_OK);
    child = fork();
    if (child == 0) {
        (void)alarm(100);                            /* that waits for threads of its parent, in vain */
    }
    for (i = 0; i < 200; i++) {
        (void)model_change(&m, live, UNIFORM, i % 4);
    }
    CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
    CHECK(model_agrees(&m, live));
    pbw_live_free(live);
    pbw_free(&mesh);
    free(points);
    model_free(&m);
    if (child == 0) {
        _exit(test_faults != 0);
    }
    CHECK(child > 0 && waitpid(child, &status, 0) == child && status == 0);
    test_end();
#endif
}

/* Points that move, one by one and by several threads, to where others are, were, or will be; with a table of places,
   which the first insertion makes, and without. */
static void test_taken_places(void)
{
    static const int threads[3] = { 1, 2, 5 };
    static const char *const names[4] = { "of one that stays", "of the next that moves", "one for two", "free" };
    int dim, way, i;
    for (dim = 2; dim <= 3; dim++) {
        for (way = 0; way < 4; way++) {
            if (!test_begin("moves to a place, %s: %dD", names[way], dim)) {
                continue;
            }
            for (i = 0; i < 6; i++) {
                pbw_options options;
                pbw_live *live;
                pbw_mesh mesh;
                double *points;
                model m;
                size_t at, k;
                CHOOSE_WAY(0);
                model_start(&m, dim, 23 + (uint64_t)way);
                CHECK_EQUAL(model_random(&m, UNIFORM, 3000, 0, &points, &mesh), PBW_OK);
                memset(&options, 0, sizeof options);
                options.threads = threads[i % 3];
                CHECK_EQUAL(pbw_live_create(&mesh, &options, &live), PBW_OK);
                CHECK(i < 3 || (model_change(&m, live, UNIFORM, 0) && pbw_live_commit(live, NULL) == PBW_OK));
                for (at = 0; at + 10 < m.count; at += 5) {
                    const pbw_index id = (pbw_index)at;
                    const size_t turn = at % 45, pair = at - turn;       /* most move a little: one by one then */
                    const double *other = points + (way == 2 ? pair + 7 : at + (way == 0 ? 1 : 5)) * (size_t)dim;
                    double *to = m.points + 3 * at;
                    const int takes = at < (i < 3 ? m.count : 45);       /* one alone may stay unnoticed later */
                    for (k = 0; k < (size_t)dim; k++) {
                        to[k] = takes && ((turn == 0 && way < 3) || (turn == 5 && way == 2))
                              ? other[k] + (way == 2 ? 1e-3 : 0.0) : to[k] + 0.01 * (other[k] - to[k]);
                    }
                    CHECK_EQUAL(pbw_live_move(live, &id, to, 1), PBW_OK);
                }
                CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
                CHECK(model_agrees(&m, live));
                pbw_live_free(live);
                pbw_free(&mesh);
                free(points);
                model_free(&m);
            }
            test_end();
        }
    }
}

/* Arrays of nonsense, and a point that has moved since: the points are triangulated all the same. */
static void test_wrong(void)
{
    int dim, i;
    for (dim = 2; dim <= 3; dim++) {
        if (!test_begin("from a wrong mesh: %dD", dim)) {
            continue;
        }
        for (i = 0; i < 40 && test_faults == 0; i++) {
            const int kind = i % KINDS;
            model m;
            pbw_mesh mesh;
            double *points;
            model_start(&m, dim, test_seed * 57 + (uint64_t)i);
            m.weighted = i / KINDS % 2;
            if (model_random(&m, kind, 60, 0, &points, &mesh) == PBW_OK) {
                const size_t entries = mesh.simplex_count * ((size_t)dim + 1);
                const pbw_index moved = mesh.simplices[0];
                pbw_index *simplices = (pbw_index *)(uintptr_t)mesh.simplices;
                pbw_index *neighbors = (pbw_index *)(uintptr_t)mesh.neighbors;
                size_t k;
                for (k = 0; k < entries; k++) {
                    simplices[k] = PBW_NONE - input_below(&m.state, 100);
                    neighbors[k] = input_below(&m.state, 100);
                }
                memset((pbw_index *)(uintptr_t)mesh.incident, 0, mesh.point_count * sizeof(pbw_index));
                model_point(&m, kind, m.points + 3 * moved);
                memcpy((double *)(uintptr_t)mesh.points + moved * (pbw_index)dim, m.points + 3 * moved,
                       (size_t)dim * sizeof(double));
                check_from_mesh(&mesh, &m, kind, 1);
            }
            pbw_free(&mesh);
            free(points);
            model_free(&m);
        }
        test_end();
    }
}

#ifdef PBW__SIMD                                        /* in test_live_local.c; test.h refuses to lose it */
/* Looks at all facets of vertices that have moved a little, which no triangulation fits: returns how many have a
   verdict by depths, and checks these with the exact signs. */
static size_t depths_verdicts(pbw_live *live, double scale)
{
    pbwl__core *core = &live->core;
    const size_t fours = core->store.count / 4 * 4, dim = (size_t)live->dim;
    pbwl__verifying verifying;
    size_t t, k, verdicts = 0, wrong = 0;
    float *depth = (float *)malloc(4 * core->store.count * sizeof(float) + 1);
    memset(&verifying, 0, sizeof verifying);
    verifying.core = core;
    verifying.scale = scale;
    memset(depth, 0xff, 4 * core->store.count * sizeof(float));      /* NaN */
    for (t = 0; t < fours; t += 4) {
        pbw_index slot[4];
        for (k = 0; k < 4; k++) {
            slot[k] = (pbw_index)(t + k);
        }
        pbwl__depths(&verifying, slot, 4, depth + 4 * t);
        for (k = 0; k < 4; k++) {
            const float first = depth[4 * (t + k)];
            wrong += first == first && pbwl__slot_side(core, t + k, live->dim + 1, NULL) <= 0;
        }
    }
    for (t = 0; t < fours; t++) {
        for (k = 0; k <= dim && core->kernel.corner[4 * t] != PBW_NONE; k++) {
            const pbw__link across = core->kernel.link[4 * t + k];
            if (depth[4 * t + k] + depth[across] > 0) {
                const double *far = pbwl__core_record(core, core->kernel.corner[across]);
                verdicts++;
                wrong += (size_t)pbw__simplex_conflict(&core->kernel, (pbw_index)t, far);
            }
        }
    }
    CHECK_EQUAL(wrong, 0);
    free(depth);
    return verdicts;
}

/* Points on a small lattice, at several scales: whole, or beside it by a few roundings or more.  From kind 64 on they
   are a small part of a box so large that the scale of depths by an orientation is denormal. */
static void test_depths(void)
{
    enum { COUNT = 400 };
    int dim, kind;
    for (dim = 2; dim <= 3 && pbw__simd_works(); dim++) {
        for (kind = 0; kind < 72 && test_begin("depths in %dD, kind %d", dim, kind); kind++) {
            const int far = kind >= 64, large = far ? (dim == 2 ? 250 : 165) : kind % 4 * 120 - 200;
            const double scale = ldexp(1, large), noise = ldexp(1, far ? -1 - kind % 8 : -(kind % 8) * 7);
            double points[3 * COUNT], weights[COUNT];
            uint64_t state = (uint64_t)kind + 1;
            pbw_live *live = NULL;
            pbw_mesh none;
            size_t i, verdicts;
            memset(&none, 0, sizeof none);
            none.dim = dim;
            CHECK(pbw_live_create(&none, NULL, &live) <= PBW_DEGENERATE);
            for (i = 0; i < COUNT * (size_t)dim; i++) {
                points[i] = scale * ((double)input_below(&state, 9) + noise * input_uniform(&state));
                weights[i / (size_t)dim] = scale * scale * noise * input_uniform(&state);
            }
            CHECK(pbw_live_insert(live, points, kind % 3 == 2 ? weights : NULL, COUNT, NULL) == PBW_OK);
            CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
            memset(&live->core.grid, 0, sizeof live->core.grid);
            for (i = (size_t)dim + 1; i < (live->core.vertex_count + 1) * ((size_t)dim + 1); i++) {
                const double nudge = noise * ldexp(input_uniform(&state) - 0.5, -(int)input_below(&state, 40));
                live->core.record[i] += i % ((size_t)dim + 1) < (size_t)dim ? scale * nudge : 0;
            }
            verdicts = depths_verdicts(live, far ? ldexp(1, -572) : pow(scale, -dim));
            CHECK(far || noise < 1e-6 || scale < 1e-25 || verdicts > 0);
            pbw_live_free(live);
            test_end();
        }
    }
}

/* Creation packs the slots in space along the curve: none is free, and few neighbours are far apart. */
static void test_packed(int threads)
{
    enum { COUNT = 20000 };
    double *points = (double *)malloc(3 * COUNT * sizeof(double));
    uint64_t state = 1;
    size_t far = 0, i;
    pbw_options options;
    pbw_live *live = NULL;
    pbw_mesh mesh;
    memset(&options, 0, sizeof options);
    options.threads = threads;
    for (i = 0; i < 3 * COUNT; i++) {
        points[i] = input_uniform(&state);
    }
    if (test_begin("packed slots, %d threads", threads)) {
        CHECK_EQUAL(pbw_triangulate(3, points, NULL, COUNT, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_live_create(&mesh, &options, &live), PBW_OK);
        for (i = 0; i < 4 * live->core.store.count; i++) {
            const size_t here = i / 4, there = live->core.store.link[i] >> 2;
            CHECK(live->core.store.corner[i] != PBW_NONE && live->core.store.link[live->core.store.link[i]] == i);
            far += here > there + 1024 || there > here + 1024;
        }
        CHECK(far < live->core.store.count / 2);     /* 0.28 of 4 links; 1.8 as built */
        pbw_live_free(live);
        pbw_free(&mesh);
        test_end();
    }
    free(points);
}
#endif

/* ---- the interface */
#ifdef PBW_LIVE_IMPLEMENTATION                          /* in test_live_local.c */
/* Simplices made by the thread of the calls, alone, and by tasks. */
static size_t made_alone(const pbw_live *live)
{
    return live->core.kernel.statistics.created;
}

static size_t made_by_tasks(const pbw_live *live)
{
    size_t made = 0, i;
    for (i = 0; i < live->core.tasks; i++) {
        made += live->core.task[i]->kernel.statistics.created;
    }
    return made;
}

/* Points that come and go at the same places, anywhere or in a box of `size`: if walks start from vertices that went,
   or all from the same one, tasks put most changes off, and one thread makes them. */
static void test_come_and_go(int dim, double size)
{
    enum { POINTS = 6000, BATCH = 2000 };
    static double points[3 * POINTS], more[3 * BATCH];
    static pbw_index ids[BATCH];
    pbw_options options;
    pbw_mesh mesh;
    pbw_live *live;
    size_t alone = 0, together = 0, i;
    int turn;
    if (!test_begin("points come and go in a box of %g, %dD: tasks make most changes", size, dim)) {
        return;
    }
    memset(&options, 0, sizeof options);
    options.threads = 3;
    verify_at = 1e9;
    input_fill(INPUT_UNIFORM, dim, POINTS, 1, points);
    input_fill(INPUT_UNIFORM, dim, BATCH, 2, more);
    for (i = 0; i < BATCH * (size_t)dim; i++) {
        more[i] = 0.5 + size * (more[i] - 0.5);
    }
    CHECK_EQUAL(pbw_triangulate(dim, points, NULL, POINTS, &options, &mesh), PBW_OK);
    CHECK_EQUAL(pbw_live_create(&mesh, &options, &live), PBW_OK);
    for (turn = 0; turn < 4; turn++) {
        alone = made_alone(live);
        together = made_by_tasks(live);
        CHECK_EQUAL(pbw_live_insert(live, more, NULL, BATCH, ids), PBW_OK);
        CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
        alone = made_alone(live) - alone;
        together = made_by_tasks(live) - together;
        CHECK(alone < together / 2);
        CHECK_EQUAL(pbw_live_remove(live, ids, BATCH), PBW_OK);
        CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
    }
    test_say("%zu simplices by one thread, %zu by tasks", alone, together);
    pbw_live_free(live);
    pbw_free(&mesh);
    test_end();
}
#endif

static void test_misuse(void)
{
    const double square[8] = { 0, 0, 1, 0, 0, 1, 1, 1 };
    double nan[2] = { 0, 0 };
    pbw_index ids[4], twice[2] = { 1, 1 }, beyond = 9;
    pbw_options options;
    pbw_live *live;
    pbw_mesh none, view;
    if (!test_begin("misuse")) {
        return;
    }
    nan[1] = HUGE_VAL - HUGE_VAL;
    memset(&none, 0, sizeof none);
    memset(&options, 0, sizeof options);
    CHECK_EQUAL(pbw_live_create(NULL, NULL, &live), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_create(&none, NULL, &live), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_create(&none, NULL, NULL), PBW_ERROR_ARGUMENT);
    none.dim = 2;
    options.flags = PBW_CURVE_ORDER;
    CHECK_EQUAL(pbw_live_create(&none, &options, &live), PBW_ERROR_ARGUMENT);
    CHECK(live == NULL);
    CHECK_EQUAL(pbw_live_create(&none, NULL, &live), PBW_DEGENERATE);
    CHECK_EQUAL(pbw_live_insert(live, square, NULL, 4, ids), PBW_OK);
    CHECK_EQUAL(pbw_live_insert(live, nan, NULL, 1, NULL), PBW_ERROR_NOT_FINITE);
    CHECK_EQUAL(pbw_live_insert(live, square, nan + 1, 1, NULL), PBW_ERROR_NOT_FINITE);
    CHECK_EQUAL(pbw_live_insert(live, NULL, NULL, 1, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
    CHECK_EQUAL(pbw_live_remove(live, twice, 2), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_remove(live, &beyond, 1), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_move(live, &beyond, square, 1), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_move(live, ids, nan, 1), PBW_ERROR_NOT_FINITE);
    CHECK_EQUAL(pbw_live_move(live, NULL, square, 3), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_view(live, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_view(NULL, &view), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_commit(NULL, NULL), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_remove(live, ids + 2, 1), PBW_OK);
    CHECK_EQUAL(pbw_live_remove(live, ids + 2, 1), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_move(live, ids + 2, square, 1), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
    CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
    CHECK_EQUAL(pbw_live_view(live, &view), PBW_OK);
    CHECK_EQUAL(view.simplex_count, 1);
    CHECK_EQUAL(view.canonical[ids[2]], PBW_NONE);
    pbw_free(&view);
    CHECK_EQUAL(pbw_live_insert(live, square, NULL, 1, &beyond), PBW_OK);
    CHECK_EQUAL(beyond, ids[2]);
    pbw_live_free(live);
    pbw_live_free(NULL);
    pbw_changes_free(NULL);
    test_end();
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 160);
    test_sequences();
    if (test_begin("each way is taken")) {
        CHECK(test_argc > 1 || (ways[0] > 0 && ways[1] > 0 && ways[2] > 0 && ways[3] > 0));
        test_say("nothing %ld, flips %ld, batch %ld, rebuild %ld", ways[0], ways[1], ways[2], ways[3]);
        test_end();
    }
    test_refusals();
    test_cancel();
    test_from_mesh();
    test_thread_counts();
    test_number_order();
    test_fork();
    test_taken_places();
    test_wrong();
    test_memory();
#ifdef PBW__SIMD
    test_depths();
    test_packed(1);
    test_packed(3);
#endif
#ifdef PBW_LIVE_IMPLEMENTATION
    test_come_and_go(2, 1);
    test_come_and_go(2, 0.01);
    test_come_and_go(3, 1);
    test_come_and_go(3, 0.01);
#endif
    test_misuse();
    return test_finish();
}
