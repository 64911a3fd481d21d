/* test_empty.c: nothing in, and almost nothing: no array where there are no entries, points without a simplex, lists
   without items.  Every interface gives its status and empty arrays; sanitizers find offsets to arrays that are not
   there. */
#include "pbw_cells.h"
#include "pbw_check.h"
#include "pbw_mesh2.h"
#include "pbw_surface.h"
#include "pbw_improve.h"
#include "pbw_mesh3.h"
#include "pbw_tiles.h"
#include "pbw_live.h"
#include "pbw_query.h"
#include "test.h"

/* none; one; two at one place; three on a line; a simplex, in the plane with a point inside. */
static const size_t counts[5] = { 0, 1, 2, 3, 5 };
static const double line[15] = { 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1 };
static const double axis[15] = { 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4 };
static const double simplex2[10] = { 0, 0, 4, 0, 0, 4, 1, 1, 0, 0 };
static const double simplex3[15] = { 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0 };
static const double weights[5] = { 0, 0, 0, -100, 0 };
static const double at[6] = { 0.5, 0.5, 0.5, 9, 9, 9 };
static const double box2[4] = { -1, -1, 5, 5 }, box3[6] = { -1, -1, -1, 5, 5, 5 };

static void test_queries(const pbw_mesh *mesh, size_t queries)
{
    pbw_lists stars, lists;
    pbw_index found[2], nearest[8];
    pbw_finder *finder = NULL;
    double distances[8];
    int scheme;
    memset(&stars, 0, sizeof stars);
    memset(&lists, 0, sizeof lists);
    CHECK(pbw_locate(mesh, queries > 0 ? at : NULL, queries, NULL, queries > 0 ? found : NULL, NULL) == PBW_OK);
    CHECK(pbw_stars(mesh, NULL, &stars) == PBW_OK);
    CHECK(pbw_nearest(mesh, &stars, at, queries, 4, NULL, nearest, distances) == PBW_OK);
    CHECK(pbw_nearest(mesh, NULL, at, queries, 1, NULL, nearest, NULL) == PBW_OK);
    CHECK(pbw_within(mesh, &stars, at, queries, 2, NULL, &lists) == PBW_OK);
    pbw_lists_free(&lists);
    for (scheme = 0; scheme < 3; scheme++) {
        (void)pbw_coordinates(mesh, at, queries, (pbw_scheme)scheme, NULL, &lists);
        pbw_lists_free(&lists);
    }
    CHECK(pbw_finder_create(mesh, NULL, &finder) == PBW_OK);
    (void)pbw_finder_locate(finder, at, NULL);
    pbw_finder_free(finder);
    pbw_lists_free(&stars);
}

static void test_cells(const pbw_mesh *mesh, const double *points, const double *w, size_t count)
{
    static const unsigned what[3] = { 0, PBW_CELLS_FACETS, PBW_CELLS_FACETS | PBW_CELLS_SHAPES | PBW_CELLS_MERGE };
    static const size_t no_ring = 0;
    pbw_domain domain;
    pbw_cells cells;
    int i, bounded;
    memset(&cells, 0, sizeof cells);
    for (i = 0; i < 3; i++) {
        for (bounded = 0; bounded < 3; bounded++) {
            memset(&domain, 0, sizeof domain);
            domain.box = bounded != 1 ? NULL : mesh->dim == 2 ? box2 : box3;
            domain.ring_first = bounded == 2 ? &no_ring : NULL;
            CHECK(pbw_cells_of(mesh, bounded > 0 ? &domain : NULL, what[i], NULL, &cells) <= PBW_DEGENERATE
                  || bounded == 2);
            pbw_cells_free(&cells);
        }
        memset(&domain, 0, sizeof domain);
        domain.box = mesh->dim == 2 ? box2 : box3;
        domain.periodic = mesh->dim == 2 ? 3 : 7;
        (void)pbw_cells_periodic(mesh->dim, points, w, count, &domain, what[i], NULL, &cells);
        pbw_cells_free(&cells);
    }
}

static void test_live(const pbw_mesh *mesh, const double *points, const double *w, size_t count)
{
    pbw_live *live = NULL;
    pbw_changes changes;
    pbw_index ids[5];
    pbw_mesh view;
    int round;
    memset(&changes, 0, sizeof changes);
    CHECK(pbw_live_create(mesh, NULL, &live) <= PBW_DEGENERATE);
    for (round = 0; round < 3; round++) {
        CHECK(pbw_live_insert(live, count > 0 ? points : NULL, w, count, count > 0 ? ids : NULL) == PBW_OK);
        CHECK(pbw_live_insert(live, NULL, NULL, 0, NULL) == PBW_OK);
        CHECK(pbw_live_commit(live, &changes) <= PBW_DEGENERATE);
        pbw_changes_free(&changes);
        CHECK(pbw_live_move(live, count > 0 ? ids : NULL, points, count) == PBW_OK || count == 0);
        CHECK(pbw_live_view(live, &view) <= PBW_DEGENERATE);
        pbw_free(&view);
        CHECK(pbw_live_commit(live, &changes) <= PBW_DEGENERATE);
        pbw_changes_free(&changes);
        CHECK(pbw_live_remove(live, count > 0 ? ids : NULL, count) == PBW_OK);
        CHECK(pbw_live_view(live, &view) <= PBW_DEGENERATE);
        pbw_free(&view);
        CHECK(pbw_live_commit(live, &changes) <= PBW_DEGENERATE);
        pbw_changes_free(&changes);
        CHECK(pbw_live_view(live, &view) <= PBW_DEGENERATE);
        CHECK_EQUAL(pbw_hash(&view, NULL), pbw_hash(mesh, NULL));
        pbw_free(&view);
    }
    pbw_live_free(live);
}

static void test_points(int dim, const double *points, size_t count)
{
    static const unsigned flags[5] = { 0, PBW_NO_NEIGHBORS, PBW_ANY_ORDER, PBW_CURVE_ORDER, PBW_BORROW };
    pbw_options options;
    pbw_report report;
    pbw_index order[5];
    pbw_mesh mesh;
    int i, weighted;
    for (weighted = 0; weighted < 2; weighted++) {
        const double *w = weighted && count > 0 ? weights : NULL, *x = count > 0 ? points : NULL;
        memset(&options, 0, sizeof options);
        for (i = 0; i < 5; i++) {
            options.flags = flags[i];
            CHECK(pbw_triangulate(dim, x, w, count, &options, &mesh) <= PBW_DEGENERATE);
            (void)pbw_hash(&mesh, NULL);
            if (i == 0) {
                CHECK(pbw_check(&mesh, NULL, &report) == PBW_OK && report.valid);
                test_queries(&mesh, 0);
                test_queries(&mesh, 2);
                test_cells(&mesh, x, w, count);
                test_live(&mesh, x, w, count);
            }
            pbw_free(&mesh);
        }
        CHECK(pbw_order(dim, x, count, NULL, count > 0 ? order : NULL) == PBW_OK);
    }
}

static void test_planes(void)
{
    static const pbw_index edge[2] = { 0, 1 };
    static const size_t first[2] = { 0, 3 };
    pbw_plane_options options;
    pbw_plane_input input;
    pbw_plane plane;
    size_t i;
    unsigned flags;
    memset(&plane, 0, sizeof plane);
    for (flags = 0; flags < 32; flags++) {
        for (i = 0; i < 10; i++) {
            memset(&options, 0, sizeof options);
            memset(&input, 0, sizeof input);
            options.flags = flags;
            options.rule = (pbw_plane_rule)(i % 3);
            input.point_count = counts[i / 2];
            input.points = input.point_count > 0 ? simplex2 : NULL;
            input.segment_count = i % 2 != 0 && input.point_count > 1;
            input.segments = input.segment_count > 0 ? edge : NULL;
            (void)pbw_plane_make(&input, &options, &plane);
            pbw_plane_free(&plane);
        }
        for (i = 0; i < 2; i++) {
            (void)pbw_plane_rings(i > 0 ? simplex2 : NULL, first, i, &options, &plane);
            pbw_plane_free(&plane);
        }
    }
}

static void test_solids(void)
{
    static const pbw_index triangle[3] = { 0, 1, 2 };
    size_t i;
    for (i = 0; i < 10; i++) {
        pbw_solid_input input;
        pbw_solid_boundary boundary;
        pbw_solid_report report;
        pbw_tets mesh;
        memset(&input, 0, sizeof input);
        memset(&mesh, 0, sizeof mesh);
        memset(&boundary, 0, sizeof boundary);
        input.point_count = counts[i / 2];
        input.points = input.point_count > 0 ? simplex3 : NULL;
        input.triangle_count = i % 2 != 0 && input.point_count > 2;
        input.triangles = input.triangle_count > 0 ? triangle : NULL;
        CHECK(pbw_solid(&input, NULL, NULL, &mesh, &boundary, &report) != PBW_OK);
        pbw_solid_boundary_free(&boundary);
    }
}

/* Two parts; one has no points. */
static void test_tiles(int dim, size_t count)
{
    pbwt_point points[5], sample[5];
    pbwt_summary summaries[2];
    pbwt_tree trees[2];
    pbwt_tile tiles[2];
    pbwt_served served;
    pbwt_cut cut;
    int part, more, rounds;
    size_t i;
    memset(points, 0, sizeof points);
    memset(trees, 0, sizeof trees);
    memset(tiles, 0, sizeof tiles);
    memset(&served, 0, sizeof served);
    for (i = 0; i < count; i++) {
        memcpy(points[i].x, dim == 2 ? simplex2 + 2 * i : simplex3 + 3 * i, (size_t)dim * sizeof(double));
        points[i].id = i;
        sample[i] = points[i];
    }
    pbwt_cut_points(dim, count > 0 ? sample : NULL, count, 2, &cut);
    for (part = 0; part < 2; part++) {
        CHECK(pbwt_tree_make(dim, part, part == 0 && count > 0 ? points : NULL, part == 0 ? count : 0, NULL,
                             trees + part) == PBW_OK);
        pbwt_summarise(trees + part, summaries + part);
    }
    for (part = 0; part < 2; part++) {
        pbwt_bytes reply = { NULL, 0 }, out = { NULL, 0 };
        CHECK(pbwt_open(tiles + part, trees + part, summaries, 2, NULL) == PBW_OK);
        for (rounds = 0, more = 1; rounds < 20 && more && test_faults == 0; rounds++) {
            CHECK(pbwt_ask(tiles + part, &more) == PBW_OK);
            if (more) {
                CHECK(pbwt_answer(trees + 1 - part, &served, tiles[part].request + 1 - part, NULL,
                                  summaries[part].count, &reply) == PBW_OK);
                CHECK(pbwt_take(tiles + part, 1 - part, reply.data, reply.size) == PBW_OK);
            }
        }
        CHECK(pbwt_leftovers(tiles + part, NULL, 0, &out) == PBW_OK);
        (void)pbwt_match((pbwt_facet *)(uintptr_t)tiles[part].facets, tiles[part].facet_count);
        pbwt_bytes_free(trees + part, &out);
        pbwt_bytes_free(trees + 1 - part, &reply);
        pbwt_served_free(trees + 1 - part, &served);
    }
    for (part = 0; part < 2; part++) {
        pbwt_close(tiles + part);
        pbwt_tree_free(trees + part);
    }
}

int main(int argc, char **argv)
{
    int dim;
    size_t i;
    test_start(argc, argv, 1);
    for (dim = 2; dim <= 3; dim++) {
        for (i = 0; i < 5; i++) {
            if (test_begin("%d points in %dD", (int)counts[i], dim)) {
                test_points(dim, line, counts[i]);
                test_points(dim, axis, counts[i]);
                test_points(dim, dim == 2 ? simplex2 : simplex3, counts[i]);
                test_end();
            }
            if (test_begin("tiles of %d points in %dD", (int)counts[i], dim)) {
                test_tiles(dim, counts[i]);
                test_end();
            }
        }
    }
    if (test_begin("planes")) {
        test_planes();
        test_end();
    }
    if (test_begin("solids")) {
        test_solids();
        test_end();
    }
    return test_finish();
}
