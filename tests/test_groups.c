/* test_groups.c: groups of elements, their names and tags go through files (examples/lib/pbw_io.h) and through
   improvement (examples/lib/pbw_improve.h).  A group is known by its measure: volume, area, length, number of points. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "../pbw.h"
#define PBW_SURFACE_IMPLEMENTATION
#include "../examples/lib/pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "../examples/lib/pbw_improve.h"
#define PBW_IO_IMPLEMENTATION
#include "../examples/lib/pbw_io.h"
#include "test.h"

enum { STEEL, GLASS, INLET, OUTLET, WALL, BETWEEN, BAFFLE, RAIL, SEAM, CORNER, GROUPS };

static const pbwio_group groups3[GROUPS] = {
    { 3, 7, (char *)(uintptr_t)"steel" }, { 3, 3, (char *)(uintptr_t)"glass & <1>" },
    { 2, 5, (char *)(uintptr_t)"inlet" }, { 2, 9, (char *)(uintptr_t)"outlet" }, { 2, 1, (char *)(uintptr_t)"wall" },
    { 2, 7, (char *)(uintptr_t)"between" }, { 2, 40, NULL }, { 1, 2, (char *)(uintptr_t)"rail" },
    { 1, 30, (char *)(uintptr_t)"seam" }, { 0, 6, (char *)(uintptr_t)"corner" }
};

/* A bar of 4 x 2 x 2 in cells of 1/2: steel to x = 2, glass from there on; a baffle at y = 1 in the glass, a rail along
   an edge of the bar, a seam inside of the steel. */
typedef struct bar {
    pbw_mesh mesh;
    double *points;
    pbw_index *regions, *patches, *edges, *edge_groups, *point_groups;
    size_t edge_count;
} bar;

static int is_at(double x, double y)
{
    return fabs(x - y) < 1e-9;
}

/* The group of a facet, by the least and the greatest coordinates of its corners. */
static pbw_index group_of_facet(const double low[3], const double high[3])
{
    if (is_at(high[0], 0) || is_at(low[0], 4)) {
        return is_at(high[0], 0) ? INLET : OUTLET;
    }
    if (is_at(high[1], 0) || is_at(low[1], 2) || is_at(high[2], 0)) {
        return WALL;
    }
    if (is_at(low[0], 2) && is_at(high[0], 2)) {
        return BETWEEN;
    }
    return is_at(low[1], 1) && is_at(high[1], 1) && low[0] >= 2.4 && high[0] <= 3.6 ? BAFFLE : PBW_NONE;
}

static void measure_box(const bar *b, const pbw_index *corner, size_t count, double low[3], double high[3])
{
    size_t i, k;
    for (k = 0; k < 3; k++) {
        low[k] = HUGE_VAL;
        high[k] = -HUGE_VAL;
        for (i = 0; i < count; i++) {
            low[k] = fmin(low[k], b->points[3 * (size_t)corner[i] + k]);
            high[k] = fmax(high[k], b->points[3 * (size_t)corner[i] + k]);
        }
    }
}

static void add_edge(bar *b, const double *from, const double *to, pbw_index group)
{
    pbw_index end[2] = { PBW_NONE, PBW_NONE };
    size_t i;
    for (i = 0; i < b->mesh.point_count; i++) {
        const double *p = b->points + 3 * i;
        end[0] = is_at(p[0], from[0]) && is_at(p[1], from[1]) && is_at(p[2], from[2]) ? (pbw_index)i : end[0];
        end[1] = is_at(p[0], to[0]) && is_at(p[1], to[1]) && is_at(p[2], to[2]) ? (pbw_index)i : end[1];
    }
    memcpy(b->edges + 2 * b->edge_count, end, sizeof end);
    b->edge_groups[b->edge_count++] = group;
}

static void make_groups(bar *b)
{
    double low[3], high[3];
    size_t i, k;
    for (i = 0; i < b->mesh.simplex_count; i++) {
        const pbw_index *t = b->mesh.simplices + 4 * i;
        measure_box(b, t, 4, low, high);
        b->regions[i] = high[0] < 2.1 ? STEEL : GLASS;
        for (k = 0; k < 4; k++) {
            const pbw_index facet[3] = { t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4] };
            measure_box(b, facet, 3, low, high);
            b->patches[4 * i + k] = group_of_facet(low, high);
        }
    }
    for (i = 0; i < 8; i++) {
        const double from[3] = { 0.5 * (double)i, 0, 2 }, to[3] = { 0.5 * (double)(i + 1), 0, 2 };
        add_edge(b, from, to, RAIL);
    }
    for (i = 1; i < 3; i++) {
        const double from[3] = { 0.5 * (double)i, 1, 1 }, to[3] = { 0.5 * (double)(i + 1), 1, 1 };
        add_edge(b, from, to, SEAM);
    }
    for (i = 0; i < b->mesh.point_count; i++) {
        const double *p = b->points + 3 * i;
        b->point_groups[i] = is_at(p[0], 4) && is_at(p[1], 2) && is_at(p[2], 2) ? CORNER : PBW_NONE;
    }
}

/* Moves points inside, off all groups, as far as tetrahedra stay positive: to a half of that. */
static void shake(bar *b)
{
    uint64_t state = test_seed;
    size_t i, t;
    int k, good, tries;
    for (i = 0; i < b->mesh.point_count; i++) {
        double *p = b->points + 3 * i, old[3];
        if (p[0] < 0.1 || p[0] > 3.9 || is_at(p[0], 2) || p[1] < 0.1 || p[1] > 1.9 || is_at(p[1], 1) || p[2] < 0.1
            || p[2] > 1.9) {
            continue;
        }
        memcpy(old, p, sizeof old);
        for (tries = 0, good = 0; tries < 4 && !good; tries++) {
            for (k = 0; k < 3; k++) {
                state = state * 6364136223846793005u + 1442695040888963407u;
                p[k] = old[k] + 0.45 * ldexp(1, -tries) * ((double)(state >> 40) / 16777216.0 - 0.5);
            }
            for (t = 0, good = 1; t < b->mesh.simplex_count && good; t++) {
                const pbw_index *c = b->mesh.simplices + 4 * t;
                good = pbw_orient3(b->points + 3 * (size_t)c[0], b->points + 3 * (size_t)c[1],
                                   b->points + 3 * (size_t)c[2], b->points + 3 * (size_t)c[3]) > 0;
            }
        }
        if (!good) {
            memcpy(p, old, sizeof old);
        }
    }
}

static void make_bar(bar *b, int shaken)
{
    size_t i;
    memset(b, 0, sizeof *b);
    b->points = (double *)malloc(9 * 5 * 5 * 3 * sizeof(double));
    for (i = 0; i < 9 * 5 * 5; i++) {
        b->points[3 * i] = 0.5 * (double)(i % 9);
        b->points[3 * i + 1] = 0.5 * (double)(i / 9 % 5);
        b->points[3 * i + 2] = 0.5 * (double)(i / 45);
    }
    CHECK(pbw_triangulate(3, b->points, NULL, 9 * 5 * 5, NULL, &b->mesh) == PBW_OK);
    b->regions = (pbw_index *)malloc(b->mesh.simplex_count * sizeof *b->regions);
    b->patches = (pbw_index *)malloc(4 * b->mesh.simplex_count * sizeof *b->patches);
    b->edges = (pbw_index *)malloc(2 * 10 * sizeof *b->edges);
    b->edge_groups = (pbw_index *)malloc(10 * sizeof *b->edge_groups);
    b->point_groups = (pbw_index *)malloc(b->mesh.point_count * sizeof *b->point_groups);
    make_groups(b);
    if (shaken) {
        shake(b);
    }
}

static void free_bar(bar *b)
{
    pbw_free(&b->mesh);
    free(b->points);
    free(b->regions);
    free(b->patches);
    free(b->edges);
    free(b->edge_groups);
    free(b->point_groups);
}

static void set_output(const bar *b, pbwio_output *o)
{
    memset(o, 0, sizeof *o);
    o->groups = groups3;
    o->group_count = GROUPS;
    o->regions = b->regions;
    o->patches = b->patches;
    o->edges = b->edges;
    o->edge_count = b->edge_count;
    o->edge_groups = b->edge_groups;
    o->point_groups = b->point_groups;
}

/* The measure of a simplex of count corners in space. */
static double measure_of(const double *points, const pbw_index *corner, int count)
{
    const double *a = points + 3 * (size_t)corner[0];
    double u[3][3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } }, n[3];
    int i, k;
    for (i = 1; i < count; i++) {
        for (k = 0; k < 3; k++) {
            u[i - 1][k] = points[3 * (size_t)corner[i] + (size_t)k] - a[k];
        }
    }
    for (k = 0; k < 3; k++) {
        n[k] = u[0][(k + 1) % 3] * u[1][(k + 2) % 3] - u[0][(k + 2) % 3] * u[1][(k + 1) % 3];
    }
    return count == 1 ? 1 : count == 2 ? sqrt(u[0][0] * u[0][0] + u[0][1] * u[0][1] + u[0][2] * u[0][2])
         : count == 3 ? sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2
         : fabs(n[0] * u[2][0] + n[1] * u[2][1] + n[2] * u[2][2]) / 6;
}

/* The measures of the groups of the bar. */
static const double measures[GROUPS] = { 8, 8, 4, 4, 24, 4, 2, 4, 1, 1 };

/* Whether a cloud has a group with the dimension, tag, measure and, unless NULL, the name. */
static int has_group(const pbwio_cloud *c, int dim, long long tag, const char *name, double measure)
{
    const pbw_index *const of[4] = { c->point_groups, c->segment_groups, c->triangle_groups, c->tetrahedron_groups };
    const pbw_index *const ids[4] = { NULL, c->segments, c->triangles, c->tetrahedra };
    const size_t counts[4] = { c->count, c->segment_count, c->triangle_count, c->tetrahedron_count };
    double sum = 0;
    size_t i, g;
    for (g = 0; g < c->group_count; g++) {
        if (c->groups[g].dim == dim && (tag == 0 || c->groups[g].tag == tag)
            && (name == NULL || (c->groups[g].name != NULL && strcmp(c->groups[g].name, name) == 0))) {
            break;
        }
    }
    for (i = 0; g < c->group_count && of[dim] != NULL && i < counts[dim]; i++) {
        const pbw_index self = (pbw_index)i;
        if (of[dim][i] == g) {
            sum += measure_of(c->points, dim == 0 ? &self : ids[dim] + (size_t)(dim + 1) * i, dim + 1);
        }
    }
    if (g == c->group_count || fabs(sum - measure) > 1e-9 * measure) {
        test_say("dimension %d, tag %lld, name %s: %g for %g", dim, tag, name != NULL ? name : "-", sum, measure);
        return 0;
    }
    return 1;
}

/* ---- files ---- */

typedef struct format { const char *name; unsigned flags; int dims, tags, names; } format;      /* dims: bits */

static void check_file(const format *f, const pbwio_cloud *c)
{
    int i;
    for (i = 0; i < GROUPS; i++) {
        const pbwio_group *g = groups3 + i;
        if (f->dims >> g->dim & 1 && !CHECK(has_group(c, g->dim, f->tags ? g->tag : 0, f->names ? g->name : NULL,
                                                      measures[i]))) {
            test_say("%s", f->name);
        }
    }
}

static void test_files(void)
{
    static const format formats[] = {
        { "a.msh", 0, 15, 1, 1 }, { "t.msh", PBWIO_TEXT, 15, 1, 1 }, { "a.msh2", 0, 15, 1, 1 }, { "a.vtu", 0, 15, 1, 1 },
        { "t.vtu", PBWIO_TEXT, 15, 1, 1 }, { "a.mesh", 0, 15, 1, 0 }
    };
    char path[64], folder[] = "/tmp/pbw-groups-XXXXXX";
    pbwio_output output;
    pbwio_cloud cloud;
    pbwio_error error;
    bar b;
    size_t i;
    make_bar(&b, 0);
    CHECK(mkdtemp(folder) != NULL);
    for (i = 0; i < sizeof formats / sizeof formats[0]; i++) {
        pbwio_options options;
        memset(&options, 0, sizeof options);
        set_output(&b, &output);
        output.flags = formats[i].flags;
        snprintf(path, sizeof path, "%s/%s", folder, formats[i].name);
        CHECK(pbwio_write(path, &b.mesh, &output, &error) == PBWIO_OK);
        options.format = pbwio_format_of(path);
        if (CHECK(pbwio_read(path, &options, &cloud, &error) == PBWIO_OK)) {
            CHECK(cloud.tetrahedron_count == b.mesh.simplex_count && cloud.dropped[0] == 0);
            check_file(formats + i, &cloud);
            pbwio_free(&cloud);
        } else {
            test_say("%s", error.text);
        }
        unlink(path);
    }
    rmdir(folder);
    free_bar(&b);
}

/* ---- improvement ---- */

/* The better mesh as a cloud; its groups are borrowed. */
static void check_better(const bar *b, const pbw_tets *t)
{
    pbwio_cloud c;
    size_t i, k, count = 0, crossed = 0;
    double low[3], high[3];
    bar view = *b;
    memset(&c, 0, sizeof c);
    c.group_count = GROUPS;
    c.groups = (pbwio_group *)(uintptr_t)groups3;
    c.points = (double *)(uintptr_t)t->points;
    c.count = t->point_count;
    c.tetrahedra = (pbw_index *)(uintptr_t)t->corners;
    c.tetrahedron_count = t->tet_count;
    c.tetrahedron_groups = (pbw_index *)(uintptr_t)t->regions;
    c.segments = (pbw_index *)(uintptr_t)t->edges;
    c.segment_count = t->edge_count;
    c.triangles = (pbw_index *)malloc(12 * t->tet_count * sizeof *c.triangles);
    c.triangle_groups = (pbw_index *)malloc(4 * t->tet_count * sizeof *c.triangle_groups);
    c.segment_groups = (pbw_index *)malloc((t->edge_count + 1) * sizeof *c.segment_groups);
    view.points = c.points;
    for (i = 0; i < 4 * t->tet_count; i++) {
        const pbw_index *s = t->corners + i / 4 * 4, n = t->neighbors[i];
        if (n != PBW_NONE) {                         /* both sides say the same */
            for (k = 0; t->neighbors[4 * (size_t)n + k] != i / 4; k++) {
            }
            CHECK(t->patches[4 * (size_t)n + k] == t->patches[i]);
        }
        if (n == PBW_NONE || i / 4 < n) {
            for (k = 0; k < 3; k++) {
                c.triangles[3 * count + k] = s[(i + 1 + k) % 4];
            }
            measure_box(&view, c.triangles + 3 * count, 3, low, high);
            CHECK(n != PBW_NONE || t->patches[i] == group_of_facet(low, high));
            c.triangle_groups[count++] = t->patches[i];
        }
    }
    c.triangle_count = count;
    for (i = 0; i < t->edge_count; i++) {
        c.segment_groups[i] = b->edge_groups[t->edge_origins[i]];
    }
    for (i = 0; i < t->tet_count; i++) {
        measure_box(&view, t->corners + 4 * i, 4, low, high);
        crossed += low[0] < 2 && high[0] > 2;
    }
    CHECK_EQUAL(crossed, 0);
    for (i = 0; i < CORNER; i++) {
        CHECK(has_group(&c, groups3[i].dim, groups3[i].tag, groups3[i].name, measures[i]));
    }
    free(c.triangles);
    free(c.triangle_groups);
    free(c.segment_groups);
}

/* How: 0 passes, 1 smoothing alone, 2 smaller sizes, 3 larger ones.  sides: which sides say the patches inside. */
static void test_improve(int how, int sides)
{
    pbw_improve_options options;
    pbw_improve_report report;
    pbw_tets in, better, again;
    double *sizes = NULL;
    bar b;
    size_t i;
    make_bar(&b, 1);
    memset(&options, 0, sizeof options);
    memset(&in, 0, sizeof in);
    for (i = 0; sides == 1 && i < 4 * b.mesh.simplex_count; i++) {
        const pbw_index n = b.mesh.neighbors[i];
        b.patches[i] = n != PBW_NONE && n < i / 4 ? PBW_NONE : b.patches[i];
    }
    in.points = b.points;
    in.point_count = b.mesh.point_count;
    in.corners = b.mesh.simplices;
    in.tet_count = b.mesh.simplex_count;
    in.regions = b.regions;
    in.patches = b.patches;
    in.edges = b.edges;
    in.edge_count = b.edge_count;
    if (how == 1) {
        options.rounds = 5;
        options.passes = -1;
    }
    if (how >= 2) {
        sizes = (double *)malloc(in.point_count * sizeof *sizes);
        for (i = 0; i < in.point_count; i++) {
            sizes[i] = how == 2 ? 0.3 : 2;
        }
        options.sizes = sizes;
    }
    if (CHECK(pbw_improve(&in, &options, NULL, &better, &report) == PBW_OK)) {
        check_better(&b, &better);
        CHECK(report.after.least_sine >= report.before.least_sine || how == 3);
        CHECK(report.moves + report.smoothings + report.removals + report.splits + report.flips > 0);
        if (CHECK(pbw_improve(&better, NULL, NULL, &again, NULL) == PBW_OK)) {      /* what comes out goes in */
            CHECK(again.edge_count == better.edge_count);
            pbw_tets_free(&again);
        }
        pbw_tets_free(&better);
    }
    free(sizes);
    free_bar(&b);
}

int main(int argc, char **argv)
{
    int how;
    test_start(argc, argv, 1);
    if (test_begin("files")) {
        test_files();
        test_end();
    }
    for (how = 0; how < 4; how++) {
        if (test_begin("improvement %d", how)) {
            test_improve(how, how % 2);
            test_end();
        }
    }
    return test_finish();
}
