/* test_groups.c: groups of elements, their names and tags go through files (examples/lib/pbw_io.h) and through
   improvement (examples/lib/pbw_improve.h).  A group is known by its measure: volume, area, length, number of points. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "../pbw.h"
#include "../examples/lib/pbw_surface.h"
#include "../examples/lib/pbw_improve.h"
#include "../examples/lib/pbw_io.h"
#include "../examples/lib/pbw_model.h"
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

/* dims: bits; names: 2 as words, 3 so and of the hull alone */
typedef struct format { const char *name; unsigned flags; int dims, tags, names; } format;

static void check_file(const format *f, const pbwio_cloud *c)
{
    char word[64];
    size_t k;
    int i;
    for (i = 0; i < GROUPS; i++) {
        const pbwio_group *g = groups3 + i;
        const char *name = f->names ? g->name : NULL;
        if (f->names >= 2) {
            snprintf(word, sizeof word, "%s", g->name != NULL ? g->name : "group_40");
            for (k = 0; word[k] != 0; k++) {
                word[k] = strchr(" &<>", word[k]) != NULL ? '_' : word[k];
            }
            name = word;
        }
        if (f->dims >> g->dim & 1 && (f->names < 3 || (i != BETWEEN && i != BAFFLE))
            && !CHECK(has_group(c, g->dim, f->tags ? g->tag : 0, name, measures[i]))) {
            test_say("%s", f->name);
        }
    }
}

/* Writes the file whose name has another ending of four letters. */
static void write_beside(const char *path, const char *ending, const bar *b, const pbwio_output *output)
{
    char name[64];
    snprintf(name, sizeof name, "%.*s.%s", (int)(strrchr(path, '.') - path), path, ending);
    CHECK(pbwio_write(name, &b->mesh, output, NULL) == PBWIO_OK);
}

/* Removes a folder and the files a.node and so on in it. */
static void unlink_beside(const char *folder)
{
    static const char *const endings[] = { "node", "ele", "face", "edge" };
    char name[64];
    size_t i;
    for (i = 0; i < 4; i++) {
        snprintf(name, sizeof name, "%s/a.%s", folder, endings[i]);
        unlink(name);
    }
    CHECK(rmdir(folder) == 0);
}

static void test_files(void)
{
    static const format formats[] = {
        { "a.msh", 0, 15, 1, 1 }, { "t.msh", PBWIO_TEXT, 15, 1, 1 }, { "a.msh2", 0, 15, 1, 1 }, { "a.vtu", 0, 15, 1, 1 },
        { "t.vtu", PBWIO_TEXT, 15, 1, 1 }, { "a.mesh", 0, 15, 1, 0 }, { "a.inp", 0, 12, 0, 2 }, { "a.su2", 0, 4, 0, 3 },
        { "a.ele", 0, 13, 1, 0 }
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
        if (strstr(path, ".ele") != NULL) {
            write_beside(path, "node", &b, &output);
            write_beside(path, "face", &b, &output);
        }
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
    unlink_beside(folder);
    free_bar(&b);
}

/* ---- what formats keep: pbwio_keeps says it, files have it, readers find it ---- */

/* Whether a text file has a word. */
static int has_word(const char *path, const char *word)
{
    size_t size;
    char *text = pbwio_load(path, NULL, &size, NULL);
    const int has = text != NULL && strstr(text, word) != NULL;
    free(text);
    return has;
}

/* Which of its groups a file of the bar has, as bits. */
static unsigned groups_in(const char *path, int corners)
{
    const int samples[5] = { corners == 3 ? BETWEEN : STEEL, INLET, BAFFLE, RAIL, CORNER };
    pbwio_cloud c;
    unsigned has = 0;
    size_t i, k;
    if (pbwio_read(path, NULL, &c, NULL) != PBWIO_OK) {
        return 0;
    }
    for (i = 0; i < 5; i++) {
        const pbwio_group *g = groups3 + samples[i];
        const int dim = g->dim;
        const pbw_index *of = dim == 3 ? c.tetrahedron_groups : dim == 2 ? c.triangle_groups : dim == 1 ? c.segment_groups
                            : c.point_groups;
        const size_t count = dim == 3 ? c.tetrahedron_count : dim == 2 ? c.triangle_count : dim == 1 ? c.segment_count
                           : c.count;
        for (k = 0; of != NULL && k < count; k++) {
            const pbwio_group *found = of[k] == PBW_NONE ? NULL : c.groups + of[k];
            if (found != NULL && (found->name == NULL ? found->tag == g->tag : strcmp(found->name, g->name != NULL ? g->name
                                                                                       : "group_40") == 0)) {
                has |= 1u << i;
                has |= found->name != NULL && g->name != NULL ? PBWIO_NAMES : 0;
                break;
            }
        }
    }
    pbwio_free(&c);
    return has;
}

/* The facets of the bar that are inlet or baffle, as a surface: triangles and their groups, in one block. */
static size_t make_surface(const bar *b, pbw_index *triangles, pbw_index *groups)
{
    static const unsigned char facets[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 0, 1, 3 }, { 0, 2, 1 } };
    size_t i, k, count = 0;
    for (i = 0; i < 4 * b->mesh.simplex_count; i++) {
        if (b->patches[i] == INLET || b->patches[i] == OUTLET) {
            for (k = 0; k < 3; k++) {
                triangles[3 * count + k] = b->mesh.simplices[i / 4 * 4 + facets[i % 4][k]];
            }
            groups[count++] = b->patches[i] == INLET ? BETWEEN : OUTLET;
        }
    }
    return count;
}

static void check_kept(const char *folder, const char *ending, const bar *b, int corners)
{
    static const char *const of_surfaces = " obj ply stl off xyz csv vtu msh msh2 mesh inp ";
    pbw_index triangles[300], groups[100];
    double values[225], weights[225];
    char path[64], word[16], text[300];
    pbwio_column column;
    pbwio_output o;
    pbwmodel_content content;
    pbw_mesh mesh = b->mesh;
    pbwio_status status;
    unsigned keeps, has;
    size_t i;
    for (i = 0; i < 225; i++) {
        values[i] = 4711.25;
        weights[i] = 7.4375;
    }
    set_output(b, &o);
    column.name = (char *)(uintptr_t)"temperature";
    column.values = values;
    o.columns = &column;
    o.column_count = 1;
    o.flags = PBWIO_TEXT;
    mesh.weights = corners == 4 ? weights : NULL;
    snprintf(path, sizeof path, "%s/a.%s", folder, ending);
    snprintf(word, sizeof word, " %s ", ending);
    keeps = pbwio_keeps(pbwio_format_of(path), corners, PBWIO_TEXT);
    if (corners == 3) {
        memset(&content, 0, sizeof content);
        content.dim = 3;
        content.points = mesh.points;
        content.point_count = mesh.point_count;
        content.triangles = triangles;
        content.triangle_count = make_surface(b, triangles, groups);
        content.output = &o;
        o.regions = groups;
        status = strstr(of_surfaces, word) == NULL ? PBWIO_ERROR_ARGUMENT : pbwmodel_write(path, &content, o.flags, NULL);
        keeps &= ~(unsigned)(PBWIO_WEIGHTS | PBWIO_PATCHES | PBWIO_INNER_PATCHES | PBWIO_HEIGHTS);
    } else {
        status = pbwio_write(path, &mesh, &o, NULL);
    }
    if (strstr(" ele face ", word) != NULL && corners == 4) {
        write_beside(path, "node", b, &o);
    }
    if (status == PBWIO_OK) {
        has = groups_in(path, corners) | (has_word(path, "temperature") || has_word(path, "4711.25") ? PBWIO_COLUMNS : 0)
            | (has_word(path, "7.4375") ? PBWIO_WEIGHTS : 0);
        if (strstr(" ele face ", word) != NULL) {
            has &= ~(unsigned)PBWIO_MARKS;                           /* those are in the .node file */
        }
        if (strstr(" node csv ", word) != NULL) {                    /* marks are numbers, not groups, in .csv */
            has |= strcmp(ending, "csv") == 0 && has_word(path, "marker") ? PBWIO_MARKS : 0;
        }
        if (!CHECK((keeps & ~(unsigned)PBWIO_HEIGHTS) == has)) {
            test_say("%s, %d corners: keeps %x, has %x", ending, corners, keeps, has);
        }
    }
    pbwio_losses(keeps, 4, &mesh, &o, text, sizeof text);
    for (i = 0; i < 5 && corners == 4; i++) {
        static const char *const words[] = { "regions", "patches", "patches inside", "edges", "markers of points" };
        CHECK((keeps >> i & 1) == (strstr(text, words[i]) == NULL) || i == 1);
    }
    CHECK((keeps & PBWIO_COLUMNS) != 0 || strstr(text, "temperature") != NULL);
    unlink(path);
}

static void test_keeps(void)
{
    static const char *const endings[] = { "obj", "ply", "stl", "off", "node", "xyz", "csv", "vtu", "msh", "msh2", "mesh",
                                           "ele", "neigh", "face", "inp", "su2" };
    char folder[] = "/tmp/pbw-groups-XXXXXX";
    bar b;
    size_t i;
    make_bar(&b, 0);
    CHECK(mkdtemp(folder) != NULL);
    for (i = 0; i < sizeof endings / sizeof endings[0]; i++) {
        check_kept(folder, endings[i], &b, 4);
        check_kept(folder, endings[i], &b, 3);
    }
    unlink_beside(folder);
    free_bar(&b);
}

/* Names that are one word, or a word that files have anyway, stay apart. */
static void test_words(void)
{
    static const char *const expected[] = { "\n*ELSET, ELSET=a_b\n", "\n*ELSET, ELSET=A_B_2\n", "NAME=a_b\n", "NAME=a_b_3\n",
        "NAME=a_b_2\n", "NAME=nall_2\n", "\n*NSET, NSET=boundary_2\n" };
    pbwio_group groups[GROUPS];
    pbwio_output o;
    bar b;
    char folder[] = "/tmp/pbw-groups-XXXXXX", path[64], text[300];
    size_t i;
    make_bar(&b, 0);
    set_output(&b, &o);
    memcpy(groups, groups3, sizeof groups);
    groups[STEEL].name = (char *)(uintptr_t)"a b";
    groups[GLASS].name = (char *)(uintptr_t)"A_B";
    groups[INLET].name = (char *)(uintptr_t)"a_b";
    groups[OUTLET].name = (char *)(uintptr_t)"a_b_2";
    groups[WALL].name = (char *)(uintptr_t)"a&b";
    groups[BETWEEN].name = (char *)(uintptr_t)"nall";
    groups[CORNER].name = (char *)(uintptr_t)"boundary";
    o.groups = groups;
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof path, "%s/a.inp", folder);
    CHECK(pbwio_write(path, &b.mesh, &o, NULL) == PBWIO_OK);
    for (i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        if (!CHECK(has_word(path, expected[i]))) {
            test_say("%s", expected[i]);
        }
    }
    pbwio_renamed(PBWIO_INP, 4, &b.mesh, &o, text, sizeof text);
    CHECK(strstr(text, "\"a b\" is a_b, \"A_B\" is A_B_2") != NULL && strstr(text, "\"nall\" is nall_2") != NULL);
    pbwio_renamed(PBWIO_SU2, 4, &b.mesh, &o, text, sizeof text);
    CHECK(strcmp(text, "\"a&b\" is a_b_3") == 0);
    unlink(path);
    groups[GLASS].name = groups[STEEL].name = (char *)(uintptr_t)"domain";      /* one group of all, as .inp has anyway */
    for (i = 0; i < b.mesh.simplex_count; i++) {
        b.regions[i] = STEEL;
    }
    CHECK(pbwio_write(path, &b.mesh, &o, NULL) == PBWIO_OK && !has_word(path, "*ELSET"));
    b.regions[0] = GLASS;
    CHECK(pbwio_write(path, &b.mesh, &o, NULL) == PBWIO_OK && has_word(path, "*ELSET, ELSET=domain_2\n")
          && has_word(path, "*ELSET, ELSET=domain_3\n"));
    unlink(path);
    unlink_beside(folder);
    free_bar(&b);
}

/* ---- spellings of .inp and .su2 ---- */

/* What a cloud has: dimension, points, tetrahedra, triangles, segments, then groups: name:dimension=elements. */
static void sum_up(const pbwio_cloud *c, char *text, size_t size)
{
    const pbw_index *const of[4] = { c->point_groups, c->segment_groups, c->triangle_groups, c->tetrahedron_groups };
    const size_t counts[4] = { c->count, c->segment_count, c->triangle_count, c->tetrahedron_count };
    size_t g, i;
    snprintf(text, size, "%d: %zu %zu %zu %zu;", c->dim, counts[0], counts[3], counts[2], counts[1]);
    for (g = 0; g < c->group_count; g++) {
        const int dim = c->groups[g].dim;
        size_t count = 0;
        for (i = 0; of[dim] != NULL && i < counts[dim]; i++) {
            count += of[dim][i] == g;
        }
        if (c->groups[g].name != NULL) {
            snprintf(text + strlen(text), size - strlen(text), " %s:%d=%zu", c->groups[g].name, dim, count);
        } else {
            snprintf(text + strlen(text), size - strlen(text), " %lld:%d=%zu", c->groups[g].tag, dim, count);
        }
    }
}

typedef struct spelling { const char *name, *text, *is, *dropped; } spelling;       /* dropped NULL: it is refused */

#define NODES "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"
#define TETS "*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n2,2,5,3,4\n"
#define TWO NODES TETS
#define REST "members that other sets have, too, of "
#define STEPS "what is no node, element, set or surface: materials, sections, steps"

static const spelling spellings[] = {
    { "plain.inp", TWO "*ELSET,ELSET=a\n1\n*ELSET,ELSET=b\n2\n", "3: 5 2 0 0; a:3=1 b:3=1", "" },
    { "case.inp", "*node\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n** c\n\n* Element , type = c3d4 , Elset = Steel\n"
      " 7 , 1 , 2 , 3 , 4 ,\n*Elset,elset=STEEL\n7\n", "3: 4 1 0 0; Steel:3=1", "" },
    { "windows.inp", "*Heading\r\n tetrahedron, one\r\n*NODE, NSET=NALL\r\n1,0,0,0\r\n2,1,0,0\r\n3,0,1,0\r\n4,0,0,1\r\n"
      "*ELEMENT,TYPE=C3D4,\r\nELSET=x\r\n1,1,2,\r\n3,4\r\n", "3: 4 1 0 0; x:3=1", "" },
    { "generate.inp", TWO "*ELSET, ELSET=odd, GENERATE\n1, 9, 2\n*NSET,NSET=low,GENERATE\n1,2\n*ELSET,ELSET=even,GENERATE"
      "\n2,2,1\n", "3: 5 2 0 0; low:0=2 odd:3=1 even:3=1", "" },
    { "nested.inp", TWO "*ELSET,ELSET=a\n1\n*ELSET,ELSET=b\n2\n*ELSET,ELSET=both\na, b\n", "3: 5 2 0 0; a:3=1 b:3=1",
      REST "both" },
    { "section.inp", TWO "*ELSET,ELSET=a\n1\n*ELSET,ELSET=late,GENERATE\n1,1\n*SOLID SECTION,ELSET=a,MATERIAL=m\n",
      "3: 5 2 0 0; a:3=1", STEPS "; " REST "late" },
    { "all.inp", NODES "*ELEMENT,TYPE=C3D4,ELSET=Eall\n1,1,2,3,4\n2,2,5,3,4\n*ELSET,ELSET=a\n2\n", "3: 5 2 0 0; a:3=1",
      REST "Eall" },
    { "only.inp", NODES "*ELEMENT,TYPE=C3D4,ELSET=Eall\n1,1,2,3,4\n2,2,5,3,4\n", "3: 5 2 0 0; Eall:3=2", "" },
    { "domain.inp", NODES "*ELEMENT,TYPE=C3D4,ELSET=domain\n1,1,2,3,4\n2,2,5,3,4\n", "3: 5 2 0 0;", "" },
    { "surface.inp", TWO "*ELSET,ELSET=e\n2\n*SURFACE,NAME=top,TYPE=ELEMENT\n1,S1\ne,s3\n*NSET,NSET=top\n1,2,3,5\n",
      "3: 5 2 2 0; e:3=1 top:2=2", "" },
    { "boundary.inp", TWO "*SURFACE,NAME=Boundary\n1,S1\n1,S2\n1,S4\n2,S1\n2,S2\n2,S3\n*SURFACE,NAME=in\n1,S1\n",
      "3: 5 2 1 0; in:2=1", "" },
    { "marks.csv", "x,y,z,marker\n0,0,0,1\n1,0,0,0\n0,1,0,\n0,0,1,1\n1,1,1,7\n", "3: 5 0 0 0; 1:0=2 7:0=1", "" },
    { "marks.txt", "marker x y\n-3 0 0\n2.0 1 0\n+2 0 1\n", "2: 3 0 0 0; -3:0=1 2:0=2", "" },
    { "late.csv", "x,y,note,Marker\n0,0,a,5\n1,0,b\n0,1,c,5\n", "2: 3 0 0 0; 5:0=2", "" },
    { "words.csv", "x,y,marker\n0,0,red\n1,0,2\n0,1,0.5\n1,1,1e300\n", "2: 4 0 0 0; 2:0=1",
      "markers that are no whole numbers" },
    { "nameless.csv", "0,0,0,1\n1,0,0,0\n0,1,0,1\n", "3: 3 0 0 0;", "" },
    { "all.inp.csv", "x,y,markers\n0,0,1\n1,0,1\n0,1,1\n", "2: 3 0 0 0;", "" },
    { "skin.inp", TWO "*SURFACE,NAME=all\n1,S1\n1,S2\n1,S4\n2,S1\n2,S2\n2,S3\n", "3: 5 2 6 0; all:2=6", "" },
    { "inside.inp", TWO "*SURFACE,NAME=wall\n1,S3\n", "3: 5 2 1 0; wall:2=1", "" },
    { "shells.inp", NODES "*ELEMENT,TYPE=S3R,ELSET=sheet\n1,1,2,3\n2,2,5,3\n*ELEMENT,TYPE=B31,ELSET=beam\n3,1,2\n"
      "*SURFACE,NAME=up\n1,SPOS\n*SURFACE,NAME=side\n1,E1\n2,S4\n", "3: 5 0 2 3; beam:1=1 sheet:2=2 side:1=2", REST "up" },
    { "plane.inp", "*NODE\n10,0,0\n20,1,0\n30,1,1\n40,0,1\n*ELEMENT,TYPE=CPE4R,ELSET=q\n5,10,20,30,40\n*SURFACE,NAME=s\n"
      "5,S2\n5,S4\n", "2: 4 0 2 2; q:2=2 s:1=2", "" },
    { "second.inp", "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n8,0,0,.5\n9,.5,0,.5\n10,0,"
      ".5,.5\n*ELEMENT,TYPE=DC3D10,ELSET=a\n1,1,2,3,4,5,6,7,\n8,9,10\n*ELEMENT,TYPE=T3D3,ELSET=bar\n2,1,5,2\n",
      "3: 4 1 0 1; bar:1=1 a:3=1", "second-order elements" },
    { "order.inp", TETS "*ELSET,ELSET=a\n1\n" NODES, "3: 5 2 0 0; a:3=1", "" },
    { "cae.inp", "*Heading\n*Part, name=P\n" TWO "*Elset, elset=mat\n 1,\n*Nset, nset=_i, internal\n 1,\n*End Part\n"
      "*Assembly, name=A\n*Instance, name=P-1, part=P\n*End Instance\n*Elset, elset=\"Set 2\", instance=P-1\n 2,\n"
      "*Node\n1,9,9,9\n*Nset, nset=ref\n1,\n*Nset, nset=tip\nP-1.4\n*End Assembly\n*Step\n*End Step\n",
      "3: 5 2 0 0; tip:0=1 mat:3=1 Set 2:3=1", "nodes and elements of the assembly" },
    { "bricks.inp", TWO "*NODE\n6,2,0,0\n7,2,1,0\n8,2,1,1\n*ELEMENT,TYPE=C3D8R,ELSET=brick\n9,1,2,3,4,5,6,7,8\n",
      "3: 8 2 0 0;", "hexahedra" },
    { "springs.inp", TWO "*ELEMENT,TYPE=SPRINGA\n9,1,2\n*ELSET,ELSET=a\n1,9\n", "3: 5 2 0 0; a:3=1",
      "elements of type SPRINGA" },
    { "include.inp", "*INCLUDE, INPUT=mesh.inp\n", "include.inp:1: lines of another file, \"mesh.inp\", are not read", NULL },
    { "input.inp", "*NODE, INPUT=n.txt\n", "input.inp:1: lines of another file, \"n.txt\", are not read", NULL },
    { "parts.inp", "*PART,NAME=a\n*END PART\n*PART,NAME=b\n", "parts.inp:3: files of one part and one instance are read",
      NULL },
    { "moved.inp", "*PART,NAME=a\n*END PART\n*ASSEMBLY\n*INSTANCE,NAME=i,PART=a\n1,0,0\n", "moved.inp:5: an instance that "
      "is moved is not read", NULL },
    { "rule.inp", "*NODE\n1,0,0,0\n*NGEN\n1,9\n", "rule.inp:3: *ngen makes nodes or elements by a rule", NULL },
    { "polar.inp", "*NODE, SYSTEM=C\n1,1,90,0\n", "polar.inp:1: nodes in a coordinate system of their own", NULL },
    { "no_node.inp", NODES "*ELEMENT,TYPE=C3D4\n1,1,2,3,9\n", "no_node.inp:8: element 1 has node 9, which is not there",
      NULL },
    { "few.inp", NODES "*ELEMENT,TYPE=C3D4\n1,1,2,3\n2,1,2,3,4\n", "few.inp:8: element 1 has 3 nodes where 4 are needed",
      NULL },
    { "twice.inp", "*NODE\n1,0,0,0\n1,1,0,0\n", "twice.inp: node 1 comes twice", NULL },
    { "member.inp", TWO "*ELSET,ELSET=a\n1,7\n", "member.inp:11: a set has element 7, which is not there", NULL },
    { "word.inp", TWO "*ELSET,ELSET=a\nwhat\n", "word.inp:11: \"what\" is neither a number nor a set so far", NULL },
    { "nameless.inp", TWO "*ELSET\n1\n", "nameless.inp:10: a set without a name", NULL },
    { "range.inp", TWO "*ELSET,ELSET=a,GENERATE\n5,1\n", "range.inp:11: numbers from 5 to 1 in steps of 1", NULL },
    { "text.inp", "*NODE\n1,a,0,0\n", "text.inp:2: coordinate 1, \"a\", is not a finite number", NULL },
    { "none.inp", "*HEADING\nnothing\n", "none.inp: the file has no points", NULL }
};

#define POINTS2 "NPOIN= 4\n0 0\n1 0\n1 1\n0 1\n"
#define TRIANGLES "NELEM= 2\n5 0 1 2\n5 0 2 3\n"

static const spelling su2s[] = {
    { "plain.su2", "NDIME= 2\n" TRIANGLES POINTS2 "NMARK= 2\nMARKER_TAG= low\nMARKER_ELEMS= 1\n3 0 1\nMARKER_TAG= rest\n"
      "MARKER_ELEMS= 2\n3 1 2\n3 2 3\n", "2: 4 0 2 3; low:1=1 rest:1=2", "" },
    { "ids.su2", "% made by hand\nNDIME=2\nNELEM =2\n5 0 1 2 0\n 5\t0 2 3 1 % last\nNPOIN = 4 4\n0 0 0\n1 0 1\n1 1 2\n0 1 3\n"
      "\nNMARK= 0\n", "2: 4 0 2 0;", "" },
    { "points_first.su2", "ndime= 2\r\n" POINTS2 TRIANGLES "NMARK= 1\nMARKER_TAG= a b \nMARKER_ELEMS= 1\nSEND_RECV= 1\n3 0 1\n",
      "2: 4 0 2 1; a b:1=1", "" },
    { "ungrouped.su2", "NDIME= 2\n" TRIANGLES POINTS2 "NMARK= 1\nMARKER_TAG= ungrouped\nMARKER_ELEMS= 1\n3 0 1\n",
      "2: 4 0 2 1;", "" },
    { "quads.su2", "NDIME= 2\nNELEM= 1\n9 0 1 2 3 0\n" POINTS2 "NMARK= 0\n", "2: 4 0 2 0;", "" },
    { "solid.su2", "NDIME= 3\nNELEM= 1\n10 0 1 2 3\nNPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\nNMARK= 1\nMARKER_TAG= 7\n"
      "MARKER_ELEMS= 1\n5 0 1 2\n", "3: 4 1 1 0; 7:2=1", "" },
    { "prism.su2", "NDIME= 3\nNELEM= 1\n13 0 1 2 0 1 2 5\nNPOIN= 3\n0 0 0\n1 0 0\n0 1 0\nNMARK= 0\nFFD_NBOX= 1\n1 2 3\n",
      "3: 3 0 0 0;", "hexahedra, prisms, pyramids and polyhedra" },
    { "zone.su2", "NZONE= 1\nIZONE= 1\nNDIME= 2\n" TRIANGLES POINTS2 "NMARK= 0\n", "2: 4 0 2 0;", "" },
    { "zones.su2", "NZONE= 2\nIZONE= 1\nNDIME= 2\n", "zones.su2:1: files of one zone are read, this has several", NULL },
    { "few.su2", "NDIME= 2\nNELEM= 3\n5 0 1 2\n5 0 2 3\n" POINTS2, "few.su2:5: the rows end 1 too early", NULL },
    { "many.su2", "NDIME= 2\nNELEM= 1\n5 0 1 2\n5 0 2 3\n" POINTS2, "many.su2:4: more rows than announced", NULL },
    { "end.su2", "NDIME= 2\n" TRIANGLES "NPOIN= 3\n0 0\n1 0\n", "end.su2:5: 3 points are announced, 8 bytes follow", NULL },
    { "cut.su2", "NDIME= 2\n" POINTS2 "NELEM= 2\n5 0 1 2\n", "cut.su2:8: the file ends 1 rows too early", NULL },
    { "marks.su2", "NDIME= 2\n" TRIANGLES POINTS2 "NMARK= 2\nMARKER_TAG= a\nMARKER_ELEMS= 1\n3 0 1\n",
      "markers: 1, announced: 2", NULL },
    { "point.su2", "NDIME= 2\nNELEM= 1\n5 0 1 4\n" POINTS2, "an element has a point that is not there, of 4", NULL },
    { "type.su2", "NDIME= 2\nNELEM= 1\n4 0 1 2\n" POINTS2, "type.su2:3: there are no elements of type 4", NULL },
    { "dim.su2", "NDIME= 4\n", "dim.su2:1: dimension 4", NULL },
    { "first.su2", "NELEM= 1\n5 0 1 2\n", "first.su2:1: rows before NDIME", NULL },
    { "tag.su2", "NDIME= 2\n" POINTS2 "MARKER_ELEMS= 1\n3 0 1\n", "tag.su2:7: elements of a marker before MARKER_TAG",
      NULL }
};

/* Whether a file was read and is so, without dropped words or with those; or, dropped NULL, was refused with words. */
static void check_cloud(const char *name, const char *is, const char *dropped, int read, pbwio_cloud *c,
                        const pbwio_error *error)
{
    char text[512];
    sum_up(c, text, sizeof text);
    if (!CHECK(read == (dropped != NULL))
        || !CHECK(read ? strcmp(text, is) == 0 && (dropped[0] == 0 ? c->dropped[0] == 0
                                                   : strstr(c->dropped, dropped) != NULL)
                       : strstr(error->text, is) != NULL)) {
        test_say("%s: %s; %s", name, read ? text : error->text, c->dropped);
    }
    pbwio_free(c);
}

static void check_spelling(const spelling *s)
{
    pbwio_cloud c;
    pbwio_error error;
    const int read = pbwio_read_memory(s->name, s->text, strlen(s->text), NULL, &c, &error) == PBWIO_OK;
    check_cloud(s->name, s->is, s->dropped, read, &c, &error);
}

static void test_spellings(void)
{
    size_t i;
    for (i = 0; i < sizeof spellings / sizeof spellings[0]; i++) {
        check_spelling(spellings + i);
    }
    for (i = 0; i < sizeof su2s / sizeof su2s[0]; i++) {
        check_spelling(su2s + i);
    }
}

/* ---- .ele with .node, .face, .edge beside it ---- */

typedef struct beside { const char *texts[4], *opens, *is, *dropped; } beside;     /* texts: .node .ele .face .edge */

#define NODE2 "4 2 0 1\n1 0 0 5\n2 1 0 0\n3 1 1 0\n4 0 1 5\n"
#define ELE2 "2 3 1\n1 1 2 3 7\n2 1 3 4 8\n"
#define NODE3 "5 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 1 1 1\n"
#define ELE3 "2 4 0\n0 0 1 2 3\n1 1 4 2 3\n"

static const beside besides[] = {
    { { NODE2, ELE2, NULL, NULL }, "ele", "2: 4 0 2 0; 5:0=2 7:2=1 8:2=1", "" },
    { { NODE2, ELE2, NULL, "3 1\n1 1 2 3\n2 2 3 0\n3 3 4 -2\n" }, "ele", "2: 4 0 2 2; 5:0=2 7:2=1 8:2=1 3:1=1 -2:1=1",
      "" },
    { { NODE2, ELE2, "what\n", "1 0\n1 1 2\n" }, "ele", "2: 4 0 2 0; 5:0=2 7:2=1 8:2=1", "" },
    { { NODE2, "2 3 1\n1 1 2 3 7\n2 1 3 4 8.5\n", NULL, NULL }, "ele", "2: 4 0 2 0; 5:0=2", "attributes of elements, which "
      "are no whole numbers" },
    { { NODE2, "2 3 1\n1 1 2 3 .5\n2 1 3 4 8\n", NULL, NULL }, "ele", "2: 4 0 2 0; 5:0=2", "attributes of elements, which "
      "are no whole numbers" },
    { { NODE2, "1 3 2\n1 1 2 3 7 .5\n", NULL, NULL }, "ele", "2: 4 0 1 0; 5:0=2 7:2=1", "attributes of elements but the "
      "first" },
    { { NODE2, "1 3 1\n1 1 2 3 x\n", NULL, NULL }, "ele", "a.ele:2: \"x\" is not a finite number", NULL },
    { { NODE2, NULL, NULL, "2 1\n1 1 2 3\n2 2 3 0\n" }, "edge", "2: 4 0 0 2; 5:0=2 3:1=1", "" },
    { { NODE3, ELE3, "2 1\n0 0 1 2 4\n1 1 2 3 9\n", NULL }, "ele", "3: 5 2 2 0; 4:2=1 9:2=1", "" },
    { { NODE3, ELE3, "# c\n2 1\n0 0 1 2 0\n1 1 2 3 9 0 1 # both\n", "1 1\n0 0 1 2\n" }, "ele",
      "3: 5 2 1 1; 9:2=1 2:1=1", "" },
    { { NODE3, ELE3, "1 1\n0 0 1 2 4 4 4 9\n", "1 1\n0 0 1 4 2\n" }, "ele", "3: 5 2 1 0; 9:2=1",
      "edges with more than two points and a marker" },
    { { NODE3, ELE3, "1 0\n0 0 1 2\n", NULL }, "ele", "3: 5 2 0 0;", "" },
    { { NODE3, NULL, "2 1\n0 0 1 2 0\n1 1 2 3 9\n", NULL }, "face", "3: 5 0 2 0; 9:2=1", "" },
    { { NODE3, ELE3, "1 1\n0 0 1 7 1\n", NULL }, "ele", "a.face:2: an element has a point that is not there, of 5", NULL },
    { { NODE3, ELE3, "2 1\n0 0 1 2 1\n", NULL }, "ele", "a.face:2: the file ends after 1 of 2 rows", NULL },
    { { NODE3, ELE3, "1 1\n0 0 1 2\n", NULL }, "ele", "a.face:2: 4 numbers where 5 are needed", NULL },
    { { NODE3, ELE3, "1 1\n0 0 1 2 1.5\n", NULL }, "ele", "a.face:2: \"1.5\" is not a number", NULL },
    { { NULL, ELE3, NULL, NULL }, "ele", "a.node: No such file", NULL }
};

static void put_text(const char *folder, const char *ending, const char *text)
{
    char name[64];
    FILE *file;
    snprintf(name, sizeof name, "%s/a.%s", folder, ending);
    unlink(name);
    file = text != NULL ? fopen(name, "wb") : NULL;
    if (file != NULL) {
        CHECK(fputs(text, file) >= 0 && fclose(file) == 0);
    }
}

static void test_beside(void)
{
    static const char *const endings[] = { "node", "ele", "face", "edge" };
    char folder[] = "/tmp/pbw-groups-XXXXXX", name[64];
    pbwio_cloud c;
    pbwio_error error;
    char *text = (char *)malloc(20000);
    size_t i, k, used, points, elements;
    CHECK(mkdtemp(folder) != NULL);
    for (i = 0; i < sizeof besides / sizeof besides[0]; i++) {
        for (k = 0; k < 4; k++) {
            put_text(folder, endings[k], besides[i].texts[k]);
        }
        snprintf(name, sizeof name, "%s/a.%s", folder, besides[i].opens);
        check_cloud(besides[i].opens, besides[i].is, besides[i].dropped,
                    pbwio_read(name, NULL, &c, &error) == PBWIO_OK, &c, &error);
    }
    used = (size_t)sprintf(text, "300 2 0 1\n");                     /* many groups of points, then of elements */
    for (i = 0; i < 300; i++) {
        used += (size_t)sprintf(text + used, "%zu %zu %zu %zu\n", i, i, i * i % 7, i + 1);
    }
    put_text(folder, "node", text);
    used = (size_t)sprintf(text, "200 3 1\n");
    for (i = 0; i < 200; i++) {
        used += (size_t)sprintf(text + used, "%zu %zu %zu %zu %zu\n", i, i, i + 1, i + 2, i + 1);
    }
    put_text(folder, "ele", text);
    put_text(folder, "edge", NULL);
    snprintf(name, sizeof name, "%s/a.ele", folder);
    if (CHECK(pbwio_read(name, NULL, &c, &error) == PBWIO_OK)) {
        CHECK(c.group_count == 500);
        for (i = points = elements = 0; i < 200; i++) {
            points += c.groups[c.point_groups[i]].dim == 0 && c.groups[c.point_groups[i]].tag == (long long)i + 1;
            elements += c.groups[c.triangle_groups[i]].dim == 2 && c.groups[c.triangle_groups[i]].tag == (long long)i + 1;
        }
        CHECK(points == 200 && elements == 200);
        pbwio_free(&c);
    }
    free(text);
    unlink_beside(folder);
}

/* Sets that name each other again and again, or many times all elements, are refused before they take long. */
static void test_many_sets(void)
{
    char *text = (char *)malloc(400000);
    pbwio_cloud c;
    pbwio_error error;
    size_t used, i;
    used = (size_t)sprintf(text, TWO "*ELSET,ELSET=s0\n1\n2,1\n");
    for (i = 1; i < 60; i++) {
        used += (size_t)sprintf(text + used, "*ELSET,ELSET=s%zu\ns%zu,s%zu\n", i, i - 1, i - 1);
    }
    CHECK(pbwio_read_memory("a.inp", text, used, NULL, &c, &error) != PBWIO_OK && c.count == 0);
    used = (size_t)sprintf(text, "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4\n");
    for (i = 1; i <= 5000; i++) {
        used += (size_t)sprintf(text + used, "%zu,1,2,3,4\n", i);
    }
    for (i = 0; i < 5000; i++) {
        used += (size_t)sprintf(text + used, "*ELSET,ELSET=%zu,GENERATE\n1,9999\n", i);
    }
    CHECK(pbwio_read_memory("a.inp", text, used, NULL, &c, &error) == PBWIO_ERROR_FORMAT);
    CHECK(strstr(error.text, "again and again") != NULL);
    free(text);
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
    if (test_begin("what formats keep")) {
        test_keeps();
        test_end();
    }
    if (test_begin("names as words")) {
        test_words();
        test_end();
    }
    if (test_begin("spellings of .inp and .su2")) {
        test_spellings();
        test_end();
    }
    if (test_begin("files beside .ele")) {
        test_beside();
        test_end();
    }
    if (test_begin("sets without end")) {
        test_many_sets();
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
