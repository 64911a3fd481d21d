/* test_live_query.c: queries on the mesh of pbw_live_view, between commits and with changes in the queue, answer as on
   a fresh build of the points that live. */
#include "pbw_live.h"
#include "pbw_query.h"
#include "test.h"
#include <math.h>

enum { MOST = 1200, QUERIES = 120, NEAREST = 4 };

static uint64_t state;
static double random_number(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) / 9007199254740992.0;
}

/* On a grid every third time, so that there are ties and duplicates. */
static void random_point(int dim, double *p)
{
    const int grid = random_number() < 0.33;
    int k;
    for (k = 0; k < dim; k++) {
        p[k] = grid ? floor(8 * random_number()) / 8 : random_number();
    }
}

/* A fresh build of the points of a view; ids: per point its number there. */
static pbw_status rebuild(const pbw_mesh *view, pbw_mesh *mesh, pbw_index *ids)
{
    static double points[3 * MOST], weights[MOST];
    const size_t dim = (size_t)view->dim;
    size_t i, count = 0;
    for (i = 0; i < view->point_count; i++) {
        if (view->canonical[i] != PBW_NONE) {
            memcpy(points + dim * count, view->points + dim * i, dim * sizeof *points);
            weights[count] = view->weights != NULL ? view->weights[i] : 0;
            ids[count++] = (pbw_index)i;
        }
    }
    return pbw_triangulate(view->dim, points, view->weights != NULL ? weights : NULL, count, NULL, mesh);
}

/* Equal but for the numbers of points: item b of the build is ids[b] of the view. */
static void compare_items(const pbw_index *a, const pbw_index *b, size_t count, const pbw_index *ids)
{
    size_t i, same = 0;
    for (i = 0; i < count; i++) {
        same += a[i] == (b[i] == PBW_NONE ? PBW_NONE : ids[b[i]]);
    }
    CHECK_EQUAL(same, count);
}

static void compare_lists(const pbw_lists *a, const pbw_lists *b, const pbw_index *ids)
{
    size_t i, same = 0;
    if (a->count == b->count) {
        for (i = 0; i <= a->count; i++) {
            same += a->first[i] == b->first[i];
        }
        CHECK_EQUAL(same, a->count + 1);
        if (same == a->count + 1) {
            compare_items(a->item, b->item, a->first[a->count], ids);
            CHECK(a->value == NULL || memcmp(a->value, b->value, a->first[a->count] * sizeof *a->value) == 0);
        }
    }
    CHECK_EQUAL(a->count, b->count);
}

/* Stars by number; a number that is free has an empty one. */
static void compare_stars(const pbw_mesh *view, const pbw_mesh *mesh, const pbw_index *ids)
{
    pbw_lists a = { 0 }, b = { 0 };
    size_t i, listed = 0;
    CHECK_EQUAL(pbw_stars(view, NULL, &a), PBW_OK);
    CHECK_EQUAL(pbw_stars(mesh, NULL, &b), PBW_OK);
    for (i = 0; i < b.count; i++) {
        const size_t count = b.first[i + 1] - b.first[i];
        CHECK_EQUAL(a.first[ids[i] + 1] - a.first[ids[i]], count);
        if (a.first[ids[i] + 1] - a.first[ids[i]] == count) {
            compare_items(a.item + a.first[ids[i]], b.item + b.first[i], count, ids);
        }
        listed += count;
    }
    CHECK(b.count > 0 && a.first[a.count] == listed);
    pbw_lists_free(&a);
    pbw_lists_free(&b);
}

static void compare(const pbw_mesh *view)
{
    static double queries[3 * QUERIES], distance[2][NEAREST * QUERIES];
    static pbw_index found[2][NEAREST * QUERIES], ids[MOST];
    pbw_lists a = { 0 }, b = { 0 };
    pbw_mesh mesh = { 0 };
    const size_t dim = (size_t)view->dim;
    size_t i;
    CHECK_EQUAL(rebuild(view, &mesh, ids), PBW_OK);
    CHECK(pbw_hash(view, NULL) == pbw_hash(&mesh, NULL));
    for (i = 0; i < QUERIES; i++) {                          /* some outside, some at points, some where points were */
        random_point(view->dim, queries + dim * i);
        queries[dim * i] += i % 8 == 0 ? 0.5 : 0;
    }
    memcpy(queries, view->points, dim * 30 * sizeof *queries);
    CHECK_EQUAL(pbw_locate(view, queries, QUERIES, NULL, found[0], NULL), PBW_OK);
    CHECK_EQUAL(pbw_locate(&mesh, queries, QUERIES, NULL, found[1], NULL), PBW_OK);
    CHECK(memcmp(found[0], found[1], QUERIES * sizeof *found[0]) == 0);
    for (i = 0; i < QUERIES; i++) {
        CHECK_EQUAL(pbw_locate_one(view, queries + dim * i, (pbw_index)i, NULL), found[1][i]);
    }
    CHECK_EQUAL(pbw_nearest(view, NULL, queries, QUERIES, NEAREST, NULL, found[0], distance[0]), PBW_OK);
    CHECK_EQUAL(pbw_nearest(&mesh, NULL, queries, QUERIES, NEAREST, NULL, found[1], distance[1]), PBW_OK);
    compare_items(found[0], found[1], NEAREST * QUERIES, ids);
    CHECK(memcmp(distance[0], distance[1], sizeof distance[0]) == 0);
    CHECK_EQUAL(pbw_within(view, NULL, queries, QUERIES, 0.1, NULL, &a), PBW_OK);
    CHECK_EQUAL(pbw_within(&mesh, NULL, queries, QUERIES, 0.1, NULL, &b), PBW_OK);
    compare_lists(&a, &b, ids);
    pbw_lists_free(&a);
    pbw_lists_free(&b);
    CHECK_EQUAL(pbw_coordinates(view, queries, QUERIES, PBW_SIBSON, NULL, &a), PBW_OK);
    CHECK_EQUAL(pbw_coordinates(&mesh, queries, QUERIES, PBW_SIBSON, NULL, &b), PBW_OK);
    compare_lists(&a, &b, ids);
    compare_stars(view, &mesh, ids);
    pbw_lists_free(&a);
    pbw_lists_free(&b);
    pbw_free(&mesh);
}

/* Queues `more` insertions, and a removal and a move of about an eighth each. */
static void queue(pbw_live *live, const pbw_mesh *view, size_t more, int weighted)
{
    double p[3], weight;
    size_t i;
    pbw_index id;
    for (i = 0; i < more; i++) {
        random_point(view->dim, p);
        weight = 0.01 * random_number();
        CHECK_EQUAL(pbw_live_insert(live, p, weighted ? &weight : NULL, 1, NULL), PBW_OK);
    }
    for (id = 0; id < view->point_count; id++) {
        const double which = random_number();
        if (view->canonical[id] != PBW_NONE && which < 0.125) {
            CHECK_EQUAL(pbw_live_remove(live, &id, 1), PBW_OK);
        } else if (view->canonical[id] != PBW_NONE && which < 0.25) {
            random_point(view->dim, p);
            CHECK_EQUAL(pbw_live_move(live, &id, p, 1), PBW_OK);
        }
    }
}

int main(int argc, char **argv)
{
    int kind, step;
    test_start(argc, argv, 600);
    for (kind = 0; kind < 4; kind++) {
        const int dim = 2 + kind % 2, weighted = kind > 1;
        pbw_mesh view = { 0 };
        pbw_live *live = NULL;
        if (!test_begin("queries in %dD%s", dim, weighted ? ", weighted" : "")) {
            continue;
        }
        state = test_seed + (uint64_t)kind;
        view.dim = dim;
        CHECK_EQUAL(pbw_live_create(&view, NULL, &live), PBW_DEGENERATE);
        for (step = 0; step < test_count / 100 && live != NULL && test_faults == 0; step++) {
            queue(live, &view, step == 0 ? 400 : 40, weighted);
            CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
            pbw_free(&view);
            CHECK_EQUAL(pbw_live_view(live, &view), PBW_OK);
            compare(&view);
            queue(live, &view, 10, weighted);
            pbw_free(&view);
            CHECK_EQUAL(pbw_live_view(live, &view), PBW_OK);         /* what is queued is not there yet */
            compare(&view);
            CHECK_EQUAL(pbw_live_commit(live, NULL), PBW_OK);
            pbw_free(&view);
            CHECK_EQUAL(pbw_live_view(live, &view), PBW_OK);
        }
        pbw_free(&view);
        pbw_live_free(live);
        test_end();
    }
    return test_finish();
}
