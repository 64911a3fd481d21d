/* test_levels.c: every public call of pbw.h keeps options.memory_limit: at 30 levels it holds no more than that, as
   an allocator counts, and gives the answer that it gives without a limit, or PBW_ERROR_MEMORY. */
#include "pbw_check.h"
#include "pbw_live.h"
#include "pbw_query.h"
#include "inputs.h"
#include "meter.h"
#include "test.h"

enum { POINTS = 1500, QUERIES = 500, CHANGES = 200 };

typedef struct given {                      /* made without a limit */
    int dim;
    double points[3 * POINTS], weights[POINTS], queries[3 * QUERIES];
    pbw_mesh mesh;
} given;

static uint64_t mixed(uint64_t digest, const void *data, size_t size)
{
    const unsigned char *byte = (const unsigned char *)data;
    size_t i;
    for (i = 0; i < size; i++) {
        digest = (digest ^ byte[i]) * UINT64_C(0x100000001b3);
    }
    return digest;
}

static uint64_t mixed_mesh(uint64_t digest, const pbw_mesh *mesh)
{
    const size_t corners = mesh->simplex_count * ((size_t)mesh->dim + 1);
    digest = corners == 0 ? digest : mixed(digest, mesh->simplices, corners * sizeof(pbw_index));
    digest = corners == 0 ? digest : mixed(digest, mesh->neighbors, corners * sizeof(pbw_index));
    digest = mixed(digest, mesh->canonical, mesh->point_count * sizeof(pbw_index));
    return mixed(digest, mesh->incident, mesh->point_count * sizeof(pbw_index));
}

static uint64_t mixed_lists(const pbw_lists *lists)
{
    uint64_t digest;
    if (lists->first == NULL) {
        return 0;
    }
    digest = mixed(1, lists->first, (lists->count + 1) * sizeof(size_t));
    digest = mixed(digest, lists->item, lists->first[lists->count] * sizeof(pbw_index));
    return lists->value == NULL ? digest : mixed(digest, lists->value, lists->first[lists->count] * sizeof(double));
}

static pbw_status triangulate(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_mesh mesh;
    pbw_status status = pbw_triangulate(g->dim, g->points, NULL, POINTS, options, &mesh);
    *digest = mixed_mesh(1, &mesh);
    pbw_free(&mesh);
    return status;
}

static pbw_status triangulate_curve(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_options own = *options;
    own.flags = PBW_CURVE_ORDER;
    return triangulate(g, &own, digest);
}

static pbw_status triangulate_floats(const given *g, const pbw_options *options, uint64_t *digest)
{
    static float points[3 * POINTS], weights[POINTS];
    pbw_mesh mesh;
    pbw_status status;
    size_t i;
    for (i = 0; i < 3 * POINTS; i++) {
        points[i] = (float)g->points[i];
        weights[i / 3] = (float)g->weights[i / 3];
    }
    status = pbw_triangulatef(g->dim, points, weights, POINTS, options, &mesh);
    *digest = mixed_mesh(1, &mesh);
    pbw_free(&mesh);
    return status;
}

static pbw_status check(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_report report;
    const pbw_status status = pbw_check(&g->mesh, options, &report);
    *digest = (uint64_t)report.valid;
    return status;
}

static pbw_status hash(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_hash_sums sums;
    const pbw_status status = pbw_hash_parts(&g->mesh, NULL, NULL, options, &sums);
    *digest = pbw_hash_of(&sums);
    return status;
}

static pbw_status order(const given *g, const pbw_options *options, uint64_t *digest)
{
    static pbw_index place[POINTS];
    const pbw_status status = pbw_order(g->dim, g->points, POINTS, options, place);
    *digest = mixed(1, place, sizeof place);
    return status;
}

static pbw_status locate(const given *g, const pbw_options *options, uint64_t *digest)
{
    static pbw_index at[2][QUERIES];
    const pbw_status status = pbw_locate(&g->mesh, g->queries, QUERIES, options, at[0], at[1]);
    *digest = mixed(1, at[0], sizeof at[0]);
    return status;
}

static pbw_status finder(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_finder *found;
    const pbw_status status = pbw_finder_create(&g->mesh, options, &found);
    *digest = status == PBW_OK ? pbw_finder_locate(found, g->queries, NULL) : 0;
    pbw_finder_free(found);
    return status;
}

static pbw_status stars(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_lists lists;
    const pbw_status status = pbw_stars(&g->mesh, options, &lists);
    *digest = mixed_lists(&lists);
    pbw_lists_free(&lists);
    return status;
}

static pbw_status nearest(const given *g, const pbw_options *options, uint64_t *digest, size_t k)
{
    static pbw_index vertices[30 * QUERIES];
    const pbw_status status = pbw_nearest(&g->mesh, NULL, g->queries, QUERIES, k, options, vertices, NULL);
    *digest = mixed(1, vertices, k * QUERIES * sizeof(pbw_index));
    return status;
}

static pbw_status nearest_two(const given *g, const pbw_options *options, uint64_t *digest)
{
    return nearest(g, options, digest, 2);
}

static pbw_status nearest_many(const given *g, const pbw_options *options, uint64_t *digest)
{
    return nearest(g, options, digest, 30);
}

static pbw_status within(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_lists lists;
    const pbw_status status = pbw_within(&g->mesh, NULL, g->queries, QUERIES, 0.1, options, &lists);
    *digest = mixed_lists(&lists);
    pbw_lists_free(&lists);
    return status;
}

static pbw_status coordinates(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_lists lists;
    const pbw_status status = pbw_coordinates(&g->mesh, g->queries, QUERIES, PBW_SIBSON, options, &lists);
    *digest = mixed_lists(&lists);
    pbw_lists_free(&lists);
    return status;
}

static pbw_status fill_range(void *arg, size_t from, size_t to)
{
    uint64_t *sum = (uint64_t *)arg;
    for (; from < to; from++) {
        *sum += from;
    }
    return PBW_OK;
}

static pbw_status loop(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_options own = *options;
    (void)g;
    *digest = 0;
    own.threads = 1;
    return pbw_for(&own, 1000, 10, fill_range, digest);
}

/* ---- live: what the caller holds of earlier calls, he frees before the next one */

static pbw_status commit_and_view(pbw_live *live, int with_changes, uint64_t *digest)
{
    pbw_changes changes;
    pbw_mesh view;
    pbw_status status = pbw_live_commit(live, with_changes ? &changes : NULL);
    if (status == PBW_OK && with_changes) {
        const size_t corners = 3;                    /* at least; the rest follows from these */
        *digest = mixed(*digest, changes.deleted, changes.deleted_count * corners * sizeof(pbw_index));
        *digest = mixed(*digest, changes.made, changes.made_count * corners * sizeof(pbw_index));
        *digest = mixed(*digest, changes.points, changes.point_count * sizeof(pbw_index));
    }
    if (with_changes) {
        pbw_changes_free(&changes);
    }
    if (status == PBW_OK) {
        status = pbw_live_view(live, &view);
        *digest = mixed_mesh(*digest, &view);
        pbw_free(&view);
    }
    return status;
}

/* Inserts, removes and moves in small batches, which are carried out one by one; then moves all a little; then far,
   which rebuilds. */
static pbw_status live_ways(const given *g, const pbw_options *options, uint64_t *digest, int with_changes)
{
    static double moved[3 * (POINTS + CHANGES)];
    const size_t dim = (size_t)g->dim;
    pbw_index ids[CHANGES];
    pbw_live *live;
    size_t i, way;
    pbw_status status = pbw_live_create(&g->mesh, options, &live);
    *digest = 1;
    for (way = 0; way < 4 && status == PBW_OK; way++) {
        if (way == 0) {
            status = pbw_live_insert(live, g->queries, NULL, CHANGES, ids);
        } else if (way == 1) {
            status = pbw_live_remove(live, ids, CHANGES / 2);
        } else {
            memcpy(moved, g->points, dim * POINTS * sizeof *moved);
            memcpy(moved + dim * POINTS, g->queries, dim * CHANGES * sizeof *moved);
            for (i = 0; i < dim * (POINTS + CHANGES); i++) {
                moved[i] = way == 2 ? moved[i] + 1e-9 * (double)(i % 7) : -moved[i] * moved[i];
            }
            status = pbw_live_move(live, NULL, moved, POINTS + CHANGES);
        }
        status = status == PBW_OK ? commit_and_view(live, with_changes, digest) : status;
    }
    pbw_live_free(live);
    return status;
}

static pbw_status live(const given *g, const pbw_options *options, uint64_t *digest)
{
    return live_ways(g, options, digest, 0);
}

static pbw_status live_changes(const given *g, const pbw_options *options, uint64_t *digest)
{
    return live_ways(g, options, digest, 1);
}

/* From no points, with weights. */
static pbw_status live_points(const given *g, const pbw_options *options, uint64_t *digest)
{
    pbw_live *live;
    pbw_mesh none;
    pbw_status status;
    memset(&none, 0, sizeof none);
    none.dim = g->dim;
    *digest = 1;
    status = pbw_live_create(&none, options, &live);
    if (status == PBW_DEGENERATE) {
        status = pbw_live_insert(live, g->points, g->weights, POINTS, NULL);
        status = status == PBW_OK ? commit_and_view(live, 1, digest) : status;
    }
    pbw_live_free(live);
    return status;
}

typedef struct call {
    const char *name;
    pbw_status (*go)(const given *g, const pbw_options *options, uint64_t *digest);
    int thrifty;                            /* with little memory it takes longer, or it needs none */
} call;

static void test_call(const given *g, const call *c, int threads)
{
    pbw_options options;
    uint64_t digest, other;
    meter m;
    size_t most, k, failed = 0;
    memset(&options, 0, sizeof options);
    options.threads = threads;
    options.resize = meter_resize;
    options.resize_user = &m;
    meter_start(&m, 0, 0);
    CHECK_EQUAL(c->go(g, &options, &digest), PBW_OK);
    CHECK(m.blocks == 0 && m.faults == 0);
    most = m.peak;
    for (k = 1; k <= 30; k++) {                      /* to 1.5 times what it holds without a limit */
        pbw_status status;
        options.memory_limit = most * k / 20 + 1;
        meter_start(&m, 0, 0);
        status = c->go(g, &options, &other);
        CHECK(status == PBW_OK ? other == digest : status == PBW_ERROR_MEMORY);
        if (!CHECK(m.peak <= options.memory_limit)) {
            test_say("level %lu: held %lu, limit %lu", (unsigned long)k, (unsigned long)m.peak,
                     (unsigned long)options.memory_limit);
        }
        CHECK(m.blocks == 0 && m.faults == 0);
        failed += status != PBW_OK;
    }
    test_say("%s, %dD, %d threads: holds %lu bytes; %lu of 30 limits suffice", c->name, g->dim, threads,
             (unsigned long)most, (unsigned long)(30 - failed));
    CHECK(c->thrifty || (failed >= 15 && failed < 30));
}

int main(int argc, char **argv)
{
    static const call calls[] = {
        { "triangulate", triangulate, 0 }, { "triangulate, in the order of the curve", triangulate_curve, 0 },
        { "triangulate floats with weights", triangulate_floats, 0 }, { "check", check, 0 }, { "hash", hash, 1 },
        { "order", order, 0 }, { "for", loop, 1 }, { "locate", locate, 0 }, { "finder", finder, 0 },
        { "stars", stars, 0 }, { "nearest two", nearest_two, 0 }, { "nearest thirty", nearest_many, 0 },
        { "within", within, 0 }, { "coordinates", coordinates, 0 }, { "live", live, 0 },
        { "live, with changes", live_changes, 0 }, { "live, from points", live_points, 0 }
    };
    static given g;
    size_t i;
    test_start(argc, argv, 0);
    for (g.dim = 2; g.dim <= 3; g.dim++) {
        input_fill(INPUT_UNIFORM, g.dim, POINTS, 1, g.points);
        input_fill(INPUT_UNIFORM, g.dim, QUERIES, 2, g.queries);
        input_fill_weights(INPUT_WEIGHTS_HIDING, g.dim, POINTS, 1, g.points, g.weights);
        CHECK_EQUAL(pbw_triangulate(g.dim, g.points, NULL, POINTS, NULL, &g.mesh), PBW_OK);
        for (i = 0; i < sizeof calls / sizeof *calls; i++) {
            if (test_begin("memory limit: %s, %dD", calls[i].name, g.dim)) {
                test_call(&g, calls + i, 1);
                test_call(&g, calls + i, 3);
                test_end();
            }
        }
        pbw_free(&g.mesh);
    }
    return test_finish();
}
