/* test_fill.c: pbw_fill.h.  A checker that knows the input and the output only, and what it must reject; parts even
   and turned, random polyhedra, cells with walls, shells that nest and touch, open sheets, wires; what is refused;
   memory, cancelling, threads. */
#include "pbw_fill.h"
#include "test.h"
#include "parts.h"
#include "meter.h"

/* ---- the checker ---- */

typedef struct result_copy {                         /* a result that may be changed */
    double *points;
    pbw_index *corners, *neighbors, *regions, *original, *patches, *facets, *facet_triangle, *facet_corners, *sides;
    size_t point_count, tet_count, facet_count;
} result_copy;

static void *copied(const void *from, size_t bytes)
{
    void *to = malloc(bytes + 1);
    if (bytes > 0) {
        memcpy(to, from, bytes);
    }
    return to;
}

static result_copy copy_of(const pbw_filled *f)
{
    const size_t id = sizeof(pbw_index), n = f->tets.tet_count;
    result_copy c;
    c.point_count = f->tets.point_count;
    c.tet_count = n;
    c.facet_count = f->facet_count;
    c.points = (double *)copied(f->tets.points, 3 * c.point_count * sizeof(double));
    c.original = (pbw_index *)copied(f->tets.original, c.point_count * id);
    c.corners = (pbw_index *)copied(f->tets.corners, 4 * n * id);
    c.neighbors = (pbw_index *)copied(f->tets.neighbors, 4 * n * id);
    c.patches = (pbw_index *)copied(f->tets.patches, 4 * n * id);
    c.regions = (pbw_index *)copied(f->tets.regions, n * id);
    c.facets = (pbw_index *)copied(f->facets, 3 * c.facet_count * id);
    c.facet_triangle = (pbw_index *)copied(f->facet_triangle, c.facet_count * id);
    c.facet_corners = (pbw_index *)copied(f->facet_corners, c.facet_count * id);
    c.sides = (pbw_index *)copied(f->sides, 2 * c.facet_count * id);
    return c;
}

static void free_copy(result_copy *c)
{
    free(c->points);
    free(c->original);
    free(c->corners);
    free(c->neighbors);
    free(c->patches);
    free(c->regions);
    free(c->facets);
    free(c->facet_triangle);
    free(c->facet_corners);
    free(c->sides);
}

static int same_place(const double *p, const double *q)
{
    return p[0] <= q[0] && p[0] >= q[0] && p[1] <= q[1] && p[1] >= q[1] && p[2] <= q[2] && p[2] >= q[2];
}

static double area_of(const double *a, const double *b, const double *c)
{
    double n[3];
    int k;
    for (k = 0; k < 3; k++) {
        const int u = (k + 1) % 3, v = (k + 2) % 3;
        n[k] = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
    }
    return sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
}

static double volume_of(const double *a, const double *b, const double *c, const double *d)
{
    double m[3][3];
    int k;
    for (k = 0; k < 3; k++) {
        m[0][k] = b[k] - a[k], m[1][k] = c[k] - a[k], m[2][k] = d[k] - a[k];
    }
    return (m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])) / 6;
}

/* Whether p, in the triangle's plane, is in the triangle. */
static int is_within(const double *const t[3], const double *p)
{
    int axis, k, low = 0, high = 0;
    for (axis = 0; axis < 3; axis++) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        double flat[3][2];
        for (k = 0; k < 3; k++) {
            flat[k][0] = t[k][u], flat[k][1] = t[k][v];
        }
        if (pbw_orient2(flat[0], flat[1], flat[2]) != 0) {
            const double q[2] = { p[u], p[v] };
            for (k = 0; k < 3; k++) {
                const int s = pbw_orient2(flat[k], flat[(k + 1) % 3], q);
                low |= s < 0;
                high |= s > 0;
            }
            return !low || !high;
        }
    }
    return 0;
}

/* Indices, points, positive tetrahedra, links.  Returns what is wrong. */
static const char *check_tets(const pbw_fill_input *in, const result_copy *f)
{
    unsigned char *used = (unsigned char *)calloc(f->point_count + 1, 1);
    const char *wrong = NULL;
    size_t i, k, j;
    for (i = 0; i < f->point_count && wrong == NULL; i++) {
        const pbw_index o = f->original[i];
        if (o != PBW_NONE && (o >= in->point_count || !same_place(in->points + 3 * (size_t)o, f->points + 3 * i))) {
            wrong = "a point is not where the input has it";
        }
        if (i > 0 && f->original[i - 1] != PBW_NONE && o != PBW_NONE && o <= f->original[i - 1]) {
            wrong = "points are not in the order of the input";
        }
    }
    for (i = 0; i < f->tet_count && wrong == NULL; i++) {
        const pbw_index *c = f->corners + 4 * i;
        for (k = 0; k < 4 && wrong == NULL; k++) {
            if (c[k] >= f->point_count) {
                wrong = "a corner is out of range";
            } else if (f->neighbors[4 * i + k] != PBW_NONE && f->neighbors[4 * i + k] >= f->tet_count) {
                wrong = "a neighbour is out of range";
            } else {
                used[c[k]] = 1;
            }
        }
        if (wrong == NULL && pbw_orient3(f->points + 3 * (size_t)c[0], f->points + 3 * (size_t)c[1],
                                         f->points + 3 * (size_t)c[2], f->points + 3 * (size_t)c[3]) <= 0) {
            wrong = "a tetrahedron is not positive";
        }
        for (k = 0; k < 4 && wrong == NULL; k++) {
            const pbw_index n = f->neighbors[4 * i + k];
            size_t common = 0, back = 0;
            for (j = 0; n != PBW_NONE && j < 16; j++) {
                common += j % 4 != k && c[j % 4] == f->corners[4 * (size_t)n + j / 4];
                back += j < 4 && f->neighbors[4 * (size_t)n + j] == i;
            }
            if (n != PBW_NONE && (common != 3 || back != 1)) {
                wrong = "a link does not fit";
            }
        }
    }
    for (i = 0; i < f->point_count && wrong == NULL; i++) {
        wrong = used[i] ? NULL : "a point is no corner";
    }
    free(used);
    return wrong;
}

/* The facets are the faces at the boundary and those with patches, each once; all names agree. */
static const char *check_facets(const pbw_fill_input *in, const result_copy *f)
{
    unsigned char *listed = (unsigned char *)calloc(4 * f->tet_count + 1, 1);
    const char *wrong = NULL;
    size_t i, k;
    for (i = 0; i < f->facet_count && wrong == NULL; i++) {
        const size_t at = f->facet_corners[i], t = at / 4;
        const pbw_index *v = f->facets + 3 * i;
        pbw_index n;
        if (at >= 4 * f->tet_count || f->facet_triangle[i] >= in->triangle_count) {
            wrong = "a facet is out of range";
            break;
        }
        n = f->neighbors[at];
        for (k = 0; k < 3; k++) {
            if (v[k] != f->corners[4 * t + PBW_FACET_CORNER(at % 4, k)]) {
                wrong = "a facet has other points than its face";
            }
        }
        if (f->patches[at] != f->facet_triangle[i]) {
            wrong = "a facet has another triangle than its patch";
        }
        if (f->sides[2 * i] != f->regions[t] || f->sides[2 * i + 1] != (n == PBW_NONE ? PBW_NONE : f->regions[n])) {
            wrong = "the sides of a facet are others";
        }
        if (listed[at]++) {
            wrong = "a facet is there twice";
        }
        for (k = 0; n != PBW_NONE && k < 4; k++) {
            if (f->neighbors[4 * (size_t)n + k] == t) {
                if (f->patches[4 * (size_t)n + k] != f->facet_triangle[i]) {
                    wrong = "patches of both sides differ";
                }
                listed[4 * (size_t)n + k]++;
            }
        }
    }
    for (i = 0; i < 4 * f->tet_count && wrong == NULL; i++) {
        const pbw_index n = f->neighbors[i];
        const int bounds = n == PBW_NONE || f->regions[n] != f->regions[i / 4] || f->patches[i] != PBW_NONE;
        wrong = bounds == (listed[i] == 1) ? NULL : "a face of the boundary is no facet, or one is a facet twice";
    }
    free(listed);
    return wrong;
}

/* Each triangle, or with merged ones each plane of them, is a union of facets; merged = 2: but for rounding. */
static const char *check_union(const pbw_fill_input *in, const result_copy *f, int merged)
{
    double *area = (double *)calloc(in->triangle_count + 1, sizeof *area), all = 0, want = 0;
    const char *wrong = NULL;
    size_t i, k;
    for (i = 0; i < f->facet_count && wrong == NULL; i++) {
        const pbw_index *t = in->triangles + 3 * (size_t)f->facet_triangle[i], *v = f->facets + 3 * i;
        const double *c[3], *p[3];
        for (k = 0; k < 3; k++) {
            c[k] = in->points + 3 * (size_t)t[k];
            p[k] = f->points + 3 * (size_t)v[k];
        }
        for (k = 0; k < 3 && wrong == NULL; k++) {
            wrong = merged < 2 && pbw_orient3(c[0], c[1], c[2], p[k]) != 0 ? "a facet is not in its triangle's plane"
                  : !merged && !is_within(c, p[k]) ? "a facet is not in its triangle" : NULL;
        }
        area[f->facet_triangle[i]] += area_of(p[0], p[1], p[2]);
        all += area_of(p[0], p[1], p[2]);
    }
    for (i = 0; i < in->triangle_count && wrong == NULL; i++) {
        const pbw_index *t = in->triangles + 3 * i;
        const double full = area_of(in->points + 3 * (size_t)t[0], in->points + 3 * (size_t)t[1],
                                    in->points + 3 * (size_t)t[2]);
        want += full;
        wrong = merged || fabs(area[i] - full) <= 1e-9 * full ? NULL : "a triangle is not covered";
    }
    if (wrong == NULL && !(fabs(all - want) <= 1e-9 * want)) {
        wrong = "the surface is not covered";
    }
    free(area);
    return wrong;
}

/* The facets are triangles of the input, so many of them, each once. */
static const char *check_exact(const pbw_fill_input *in, const result_copy *f, size_t count)
{
    unsigned char *found = (unsigned char *)calloc(in->triangle_count + 1, 1);
    const char *wrong = f->facet_count == count ? NULL : "there are more facets than triangles, or fewer";
    size_t i, k, j;
    for (i = 0; i < f->facet_count && wrong == NULL; i++) {
        const pbw_index *t = in->triangles + 3 * (size_t)f->facet_triangle[i];
        size_t common = 0;
        for (k = 0; k < 9; k++) {
            j = f->original[f->facets[3 * i + k / 3]];
            common += j != PBW_NONE && same_place(in->points + 3 * j, in->points + 3 * (size_t)t[k % 3]);
        }
        wrong = common != 3 ? "a facet has other corners than its triangle" : found[f->facet_triangle[i]]++
              ? "a triangle has two facets" : NULL;
    }
    free(found);
    return wrong;
}

/* Returns what is wrong with a result, NULL if nothing; volume < 0: not known. */
static const char *fault_of(const pbw_fill_input *in, const result_copy *f, int merged, double volume)
{
    const char *wrong = check_tets(in, f);
    double sum = 0;
    size_t i;
    wrong = wrong != NULL ? wrong : check_facets(in, f);
    wrong = wrong != NULL ? wrong : check_union(in, f, merged);
    for (i = 0; i < f->tet_count && wrong == NULL; i++) {
        const pbw_index *c = f->corners + 4 * i;
        sum += volume_of(f->points + 3 * (size_t)c[0], f->points + 3 * (size_t)c[1], f->points + 3 * (size_t)c[2],
                         f->points + 3 * (size_t)c[3]);
    }
    return wrong != NULL ? wrong : volume < 0 || fabs(sum - volume) <= 1e-9 * volume ? NULL : "the volume is another";
}

/* ---- inputs ---- */

typedef struct surface { double x[40000][3]; pbw_index t[60000][3]; size_t points, triangles; } surface;
static surface big;                                  /* for all tests, one after the other */
static int full_bits;                                /* of coordinates: points that stay on edges round */

/* Rounds a coordinate to 2^-20, so that points on edges are at doubles. */
static double rounded(double x)
{
    return floor(ldexp(x, 20) + 0.5) * ldexp(1, -20);
}

static double random_in(uint64_t *key, double from, double to)
{
    return from + (to - from) * (double)(pbw_random(test_seed, (*key)++) >> 11) * ldexp(1, -53);
}

static pbw_fill_input input_of(const double *x, size_t points, const pbw_index *t, size_t triangles)
{
    pbw_fill_input in;
    memset(&in, 0, sizeof in);
    in.points = x;
    in.point_count = points;
    in.triangles = t;
    in.triangle_count = triangles;
    return in;
}

static pbw_fill_input input_of_big(void)
{
    return input_of(big.x[0], big.points, big.t[0], big.triangles);
}

static void triangle(size_t a, size_t b, size_t c)
{
    pbw_index *t = big.t[big.triangles++];
    t[0] = (pbw_index)a, t[1] = (pbw_index)b, t[2] = (pbw_index)c;
}

static size_t point(double x, double y, double z)
{
    double *p = big.x[big.points];
    p[0] = x, p[1] = y, p[2] = z;
    return big.points++;
}

/* The volume that closed shells enclose, turned outward. */
static double enclosed(const pbw_fill_input *in)
{
    static const double origin[3] = { 0, 0, 0 };
    double sum = 0;
    size_t i;
    for (i = 0; i < in->triangle_count; i++) {
        const pbw_index *t = in->triangles + 3 * i;
        sum += volume_of(origin, in->points + 3 * (size_t)t[0], in->points + 3 * (size_t)t[1],
                         in->points + 3 * (size_t)t[2]);
    }
    return fabs(sum);
}

/* A polyhedron that its centre sees all of: the hull of points on a sphere, each moved along its ray.  The first four
   are those of a tetrahedron, so that the centre is inside. */
static void add_star(size_t count, double least, const double centre[3], double size, uint64_t *key)
{
    static double x[400][3];
    const size_t first = big.points;
    pbw_mesh mesh;
    size_t i, k;
    memset(&mesh, 0, sizeof mesh);
    for (i = 0; i < count; i++) {
        double length;
        do {
            for (k = 0; k < 3; k++) {
                x[i][k] = i >= 4 ? random_in(key, -1, 1) : i == 0 || i == k + 1 ? 0.5 : -0.5;
            }
            length = sqrt(x[i][0] * x[i][0] + x[i][1] * x[i][1] + x[i][2] * x[i][2]);
        } while (length < 0.1 || length > 1);
        for (k = 0; k < 3; k++) {
            x[i][k] /= length;
        }
    }
    CHECK_EQUAL(pbw_triangulate(3, x[0], NULL, count, NULL, &mesh), PBW_OK);
    for (i = 0; i < count; i++) {
        const double r = size * random_in(key, least, 1);
        (void)point(rounded(centre[0] + r * x[i][0]), rounded(centre[1] + r * x[i][1]),
                    rounded(centre[2] + r * x[i][2]));
    }
    for (i = 0; i < 4 * mesh.simplex_count; i++) {
        if (mesh.neighbors[i] == PBW_NONE) {
            const pbw_index *c = mesh.simplices + i / 4 * 4;
            triangle(first + c[PBW_FACET_CORNER(i % 4, 0)], first + c[PBW_FACET_CORNER(i % 4, 1)],
                     first + c[PBW_FACET_CORNER(i % 4, 2)]);
        }
    }
    pbw_free(&mesh);
}

/* n^3 cells; inner corners move by up to `jitter`; walls are given once.  Returns the number of cells. */
static size_t make_cells(size_t n, double jitter, uint64_t *key)
{
    const size_t m = n + 1;
    size_t i, axis;
    big.points = big.triangles = 0;
    for (i = 0; i < m * m * m; i++) {
        const size_t c[3] = { i % m, i / m % m, i / m / m };
        double x[3];
        for (axis = 0; axis < 3; axis++) {
            x[axis] = rounded((double)c[axis] + (c[axis] > 0 && c[axis] < n ? random_in(key, -jitter, jitter) : 0));
        }
        (void)point(x[0], x[1], x[2]);
    }
    for (i = 0; i < 3 * m * m * m; i++) {
        const size_t step[3] = { 1, m, m * m }, at = i / 3;
        const size_t u = (i % 3 + 1) % 3, v = (i % 3 + 2) % 3, c[3] = { at % m, at / m % m, at / m / m };
        if (c[u] < n && c[v] < n) {
            triangle(at, at + step[u], at + step[u] + step[v]);
            triangle(at, at + step[u] + step[v], at + step[v]);
        }
    }
    return n * n * n;
}

static void add_box(double low, double high)
{
    static const int face[12][3] = { { 0, 2, 3 }, { 0, 3, 1 }, { 4, 5, 7 }, { 4, 7, 6 }, { 0, 1, 5 }, { 0, 5, 4 },
                                     { 2, 6, 7 }, { 2, 7, 3 }, { 0, 4, 6 }, { 0, 6, 2 }, { 1, 3, 7 }, { 1, 7, 5 } };
    const size_t first = big.points;
    size_t i;
    for (i = 0; i < 8; i++) {
        (void)point(i & 1 ? high : low, i & 2 ? high : low, i & 4 ? high : low);
    }
    for (i = 0; i < 12; i++) {
        triangle(first + (size_t)face[i][0], first + (size_t)face[i][1], first + (size_t)face[i][2]);
    }
}

/* ---- tests ---- */

/* Fills, checks the result.  Returns the number of regions. */
static size_t fill_and_check(const pbw_fill_input *in, const pbw_fill_options *how, double volume)
{
    pbw_filled f;
    pbw_fill_report report;
    const pbw_status status = pbw_fill(in, how, NULL, &f, &report);
    CHECK_EQUAL(status, PBW_OK);
    if (status == PBW_OK) {
        result_copy c = copy_of(&f);
        const int exact = how == NULL || !how->conforming;
        const char *wrong = how != NULL && how->outside ? check_tets(in, &c)
                          : fault_of(in, &c, exact ? 0 : full_bits ? 2 : !how->split_flat, volume);
        wrong = wrong == NULL && exact ? check_exact(in, &c, in->triangle_count - report.doubles - report.collapsed)
              : wrong;
        CHECK_EQUAL(report.refusal, PBW_FILL_FILLED);
        if (!CHECK(wrong == NULL)) {
            test_say("%s", wrong);
        }
        CHECK_EQUAL(report.flat_tets, 0);
        free_copy(&c);
    } else {
        test_say("%s, %zu faults", pbw_fill_refusal(report.refusal), report.fault_count);
    }
    pbw_fill_free(&f);
    return report.regions;
}

static void test_all_parts(void)
{
    static part m;
    size_t i, k;
    for (i = 0; i < 2 * PART_COUNT; i++) {
        pbw_fill_options how;
        memset(&how, 0, sizeof how);
        if (test_begin("part %s%s", parts[i / 2].name, i % 2 == 1 ? ", turned" : "")) {
            pbw_fill_input in;
            (void)part_make(i / 2, i % 2 == 1, &m);
            for (k = 0; k < 3 * m.points; k++) {
                m.x[k / 3][k % 3] = rounded(m.x[k / 3][k % 3]);
            }
            in = input_of(m.x[0], m.points, m.t[0], m.triangles);
            for (k = 0; k < 3; k++) {                /* exact, flat facets, triangles */
                how.conforming = k > 0;
                how.split_flat = k > 1;
                (void)fill_and_check(&in, &how, enclosed(&in));
            }
            test_end();
        }
    }
}

/* The number of points that are added to all parts is bounded: on segments, and of these, those that stay inside. */
static void test_few_points(void)
{
    static part m;
    size_t i, k, segments = 0, inside = 0, triangles = 0;
    if (test_begin("few points on segments, few stay inside")) {
        for (i = 0; i < 2 * PART_COUNT; i++) {
            pbw_fill_input in;
            pbw_fill_options how;
            pbw_fill_report report;
            pbw_filled filled;
            memset(&how, 0, sizeof how);
            memset(&filled, 0, sizeof filled);
            (void)part_make(i / 2, i % 2 == 1, &m);
            for (k = 0; k < 3 * m.points; k++) {
                m.x[k / 3][k % 3] = rounded(m.x[k / 3][k % 3]);
            }
            in = input_of(m.x[0], m.points, m.t[0], m.triangles);
            for (how.conforming = 0; how.conforming < 2; how.conforming++) {
                CHECK(pbw_fill(&in, &how, NULL, &filled, &report) == PBW_OK);
                segments += how.conforming ? report.segment_points : 0;
                inside += how.conforming ? 0 : report.inner_points;
                pbw_fill_free(&filled);
            }
            triangles += in.triangle_count;
        }
        CHECK(segments > 0 && segments < 3000);      /* 2,343 */
        if (!CHECK(inside > 0 && 110 * inside < triangles)) {
            test_say("%zu points of %zu triangles stay inside", inside, triangles);
        }
        test_end();
    }
}

static void test_stars(void)
{
    uint64_t key = 0;
    long i;
    if (test_begin("polyhedra")) {
        for (i = 0; i < test_count; i++) {
            static const double centre[3] = { 0, 0, 0 };
            pbw_fill_input in;
            pbw_fill_options how;
            memset(&how, 0, sizeof how);
            how.split_flat = i % 2 == 0;
            how.conforming = i % 3 > 0;
            big.points = big.triangles = 0;
            add_star(4 + (size_t)random_in(&key, 0, i % 10 == 0 ? 300 : 40), i % 3 == 0 ? 0.05 : 0.4, centre, 1,
                     &key);
            in = input_of_big();
            (void)fill_and_check(&in, &how, enclosed(&in));
        }
        test_end();
    }
}

static double size_in_half(void *user, const double place[3])
{
    (void)user;
    return place[0] > 0 ? 0.15 : 0;                  /* any in the other half */
}

static double volume_at(const pbw_filled *f, size_t tet)
{
    const pbw_index *c = f->tets.corners + 4 * tet;
    const double *p = f->tets.points;
    return volume_of(p + 3 * (size_t)c[0], p + 3 * (size_t)c[1], p + 3 * (size_t)c[2], p + 3 * (size_t)c[3]);
}

/* Points with all bits are where the input has them (the checker demands that), in turned parts, with their many flat
   quadrilaterals, too. */
static void test_full_bits(void)
{
    static const double centre[3] = { 0, 0, 0 };
    static part m;
    uint64_t key = 0;
    size_t i, k;
    full_bits = 1;
    for (k = 0; k < 3; k++) {
        pbw_fill_options how;
        memset(&how, 0, sizeof how);
        how.conforming = k > 0;
        how.split_flat = k > 1;
        if (test_begin("coordinates with all bits, mode %zu", k)) {
            for (i = 0; i < PART_COUNT; i++) {
                pbw_fill_input in;
                (void)part_make(i, 1, &m);
                in = input_of(m.x[0], m.points, m.t[0], m.triangles);
                (void)fill_and_check(&in, &how, enclosed(&in));
            }
            for (i = 0; i < 30; i++) {
                pbw_fill_input in;
                size_t j;
                big.points = big.triangles = 0;
                add_star(4 + (size_t)random_in(&key, 0, 60), 0.2, centre, 1, &key);
                for (j = 0; j < 3 * big.points; j++) {
                    big.x[j / 3][j % 3] /= 3;
                }
                in = input_of_big();
                (void)fill_and_check(&in, &how, enclosed(&in));
            }
            test_end();
        }
    }
    full_bits = 0;
}

/* Lets the allocations fail, all of the first few, then some.  Returns the most memory that the fill takes. */
static size_t fail_allocations(const pbw_fill_input *in, const pbw_fill_options *how, long step)
{
    pbw_options options;
    pbw_filled f;
    meter memory;
    long k, requests;
    size_t peak;
    memset(&options, 0, sizeof options);
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &memory;
    meter_start(&memory, 0, 0);
    CHECK_EQUAL(pbw_fill(in, how, &options, &f, NULL), PBW_OK);
    requests = memory.requests, peak = memory.peak;
    pbw_fill_free(&f);
    CHECK(memory.blocks == 0 && memory.faults == 0);
    for (k = 1; k <= requests; k += 1 + k / step) {
        meter_start(&memory, k, 1);
        CHECK_EQUAL(pbw_fill(in, how, &options, &f, NULL), PBW_ERROR_MEMORY);
        CHECK(memory.blocks == 0 && memory.faults == 0 && f.memory == NULL);
    }
    return peak;
}

/* Parts that are small in a box: nothing moves. */
static void test_wide_boxes(void)
{
    static const struct { size_t part; double wide; int conforming; } cases[4] = {
        { PART_HOLE, 1e5, 1 }, { PART_HOLE, 1e5, 0 }, { PART_GEAR, 2e7, 1 }, { PART_GEAR, 2e7, 0 }
    };
    size_t i, k;
    full_bits = 1;
    for (i = 0; i < 4; i++) {
        if (test_begin("turned parts in wide boxes, %zu", i)) {
            static part m;
            pbw_fill_options how;
            pbw_fill_input in;
            (void)part_make(cases[i].part, 1, &m);
            big.points = big.triangles = 0;
            add_box(-cases[i].wide, cases[i].wide);
            for (k = 0; k < m.points; k++) {
                (void)point(m.x[k][0], m.x[k][1], m.x[k][2]);
            }
            for (k = 0; k < m.triangles; k++) {
                triangle((size_t)8 + m.t[k][0], (size_t)8 + m.t[k][1], (size_t)8 + m.t[k][2]);
            }
            memset(&how, 0, sizeof how);
            how.conforming = cases[i].conforming;
            how.nested = 1;
            in = input_of_big();
            (void)fill_and_check(&in, &how, pow(2 * cases[i].wide, 3));
            if (i == 0) {
                (void)fail_allocations(&in, &how, 4);
            }
            test_end();
        }
    }
    full_bits = 0;
}

/* Appends the part, its coordinates rounded to 2^-14, with that scale and place. */
static void add_part(size_t number, double scale, double place)
{
    static part m;
    const size_t first = big.points;
    size_t i;
    (void)part_make(number, 1, &m);
    for (i = 0; i < m.points; i++) {
        double x[3];
        int k;
        for (k = 0; k < 3; k++) {
            x[k] = place + scale * ldexp(floor(ldexp(m.x[i][k], 14) + 0.5), -14);
        }
        (void)point(x[0], x[1], x[2]);
    }
    for (i = 0; i < m.triangles; i++) {
        triangle(first + m.t[i][0], first + m.t[i][1], first + m.t[i][2]);
    }
}

/* Details that are small in a box, down to single doubles: filled exactly. */
static void test_fine(void)
{
    pbw_fill_options how;
    pbw_fill_input in;
    size_t i;
    memset(&how, 0, sizeof how);
    how.nested = 1;
    if (test_begin("details of 2^-30 of the box")) {
        const double wide = ldexp(1, 18);
        for (i = 0; i < PART_COUNT; i++) {
            big.points = big.triangles = 0;
            add_box(0, wide);
            add_part(i, ldexp(1, -12), ldexp(1, 17) + (double)i);
            in = input_of_big();
            how.conforming = i % 2 == 0;
            (void)fill_and_check(&in, &how, wide * wide * wide);
        }
        how.conforming = 0;
        (void)fail_allocations(&in, &how, 4);
        test_end();
    }
    if (test_begin("shells near each other")) {
        for (i = 30; i <= 52; i++) {                 /* the last ones are one double apart */
            const double gap = ldexp(1, -(int)i);
            how.conforming = i > 50;                 /* no place there for points that are taken off edges */
            big.points = big.triangles = 0;
            add_box(-2, 2), add_box(-1, 1), add_box(-1 - gap, 1 + gap);
            in = input_of_big();
            CHECK_EQUAL(fill_and_check(&in, &how, 64), 3);
            big.points = big.triangles = 0;
            add_box(-1, 1), add_box(1 + gap, 3);
            in = input_of_big();
            CHECK_EQUAL(fill_and_check(&in, &how, enclosed(&in)), 2);
        }
        for (i = 30; i <= 270; i += 30) {
            const double half = pow(10, -(double)i);
            how.conforming = i > 60;
            big.points = big.triangles = 0;
            add_box(-1, 1), add_box(-half, half);
            in = input_of_big();
            CHECK_EQUAL(fill_and_check(&in, &how, 8), 2);
        }
        test_end();
    }
}

/* A turned part and a copy, shifted along an axis by its width and a gap there. */
static void add_pair(size_t which, size_t axis, double gap)
{
    static part m;
    size_t i, k, left = 0, right = 0;
    (void)part_make(which, 1, &m);
    big.points = big.triangles = 0;
    for (i = 0; i < m.points; i++) {                 /* the corner on the left beside that on the right */
        left = m.x[i][axis] < m.x[left][axis] ? i : left;
        right = m.x[i][axis] > m.x[right][axis] ? i : right;
    }
    for (i = 0; i < 2 * m.points; i++) {
        double x[3];
        for (k = 0; k < 3; k++) {
            x[k] = m.x[i % m.points][k] + (i < m.points ? 0 : m.x[right][k] - m.x[left][k]);
        }
        x[axis] += i < m.points ? 0 : gap;
        (void)point(x[0], x[1], x[2]);
    }
    for (i = 0; i < 2 * m.triangles; i++) {
        const pbw_index *t = m.t[i % m.triangles];
        const size_t first = i < m.triangles ? 0 : m.points;
        triangle(first + t[0], first + t[1], first + t[2]);
    }
}

/* Two bodies with corners some doubles apart, turned, so that no doubles are on their edges. */
static void test_no_doubles(void)
{
    pbw_fill_options how;
    pbw_fill_input in;
    size_t i;
    memset(&how, 0, sizeof how);
    if (test_begin("an edge without doubles on it")) {
        add_pair(PART_L, 0, 1e-15);
        in = input_of_big();
        (void)fill_and_check(&in, NULL, enclosed(&in));
        (void)fail_allocations(&in, NULL, 40);
        test_end();
    }
    full_bits = 1;
    for (how.conforming = 0; how.conforming < 2; how.conforming++) {
        if (test_begin("gaps of some doubles, %s", how.conforming ? "conforming" : "exact")) {
            for (i = 0; i < PART_COUNT; i++) {
                add_pair(i, i % 3, ldexp(1, -40 - (int)(5 * i % 14)));
                in = input_of_big();
                (void)fill_and_check(&in, &how, enclosed(&in));
            }
            add_pair(2, 0, ldexp(5, -55));           /* points that are at doubles turn tetrahedra */
            in = input_of_big();
            (void)fill_and_check(&in, &how, enclosed(&in));
            (void)fail_allocations(&in, &how, 5);
            test_end();
        }
    }
    full_bits = 0;
}

/* A box with rows of needles, turned: their planes differ by roundings, so that all of their edges are segments. */
static void test_needles(void)
{
    static const int corner[4][2] = { { 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } };
    enum { NEEDLES = 200 };
    size_t i, k;
    if (test_begin("rows of needles")) {
        const double c = cos(0.7), s = sin(0.7), c2 = cos(0.3), s2 = sin(0.3);
        pbw_fill_report report;
        pbw_fill_input in;
        pbw_filled f;
        big.points = big.triangles = 0;
        for (i = 0; i < 4 * (NEEDLES + 1); i++) {
            const double x = NEEDLES * corner[i % 4][0], y = (double)(i / 4) / NEEDLES, z = corner[i % 4][1];
            (void)point(c * x - s * y, c2 * (s * x + c * y) - s2 * z, s2 * (s * x + c * y) + c2 * z);
        }
        for (i = 0; i < 4 * NEEDLES; i++) {
            const size_t a = i, b = i / 4 * 4 + (i + 1) % 4;
            triangle(a, b, b + 4), triangle(a, b + 4, a + 4);
        }
        i = 4 * NEEDLES;
        triangle(0, 2, 1), triangle(0, 3, 2), triangle(i, i + 1, i + 2), triangle(i, i + 2, i + 3);
        in = input_of_big();
        CHECK_EQUAL(pbw_fill(&in, NULL, NULL, &f, &report), PBW_OK);
        CHECK(report.segment_points > NEEDLES && report.segment_points < 6 * NEEDLES && report.flat_tets == 0);
        if (f.tets.tet_count > 0) {                  /* a point may stay on an edge, and is told */
            result_copy copy = copy_of(&f);
            const char *wrong = fault_of(&in, &copy, 2, enclosed(&in));
            for (i = k = 0; i < 3 * copy.facet_count; i++) {
                k += copy.original[copy.facets[i]] == PBW_NONE;
            }
            CHECK((k > 0) == (report.refusal == PBW_FILL_POINTS_LEFT) && k < 20);
            CHECK((report.fault_count > 0) == (report.refusal == PBW_FILL_POINTS_LEFT));
            if (!CHECK(wrong == NULL)) {
                test_say("%s", wrong);
            }
            free_copy(&copy);
        }
        pbw_fill_free(&f);
        test_end();
    }
}

static void test_improvement(void)
{
    uint64_t key = 77;
    if (test_begin("better angles, the same facets")) {
        const char *stage = "";
        static const double centre[3] = { 0, 0, 0 };
        pbw_fill_options how;
        pbw_fill_report report;
        pbw_fill_input in;
        pbw_filled f;
        memset(&how, 0, sizeof how);
        how.improve.target = 15;
        how.improve.passes = 8;
        how.stage = &stage;
        big.points = big.triangles = 0;
        add_star(100, 0.8, centre, 1, &key);
        (void)point(0.125, 0.25, 0.125);             /* of no triangle: it stays */
        in = input_of_big();
        (void)fill_and_check(&in, &how, enclosed(&in));
        CHECK_EQUAL(pbw_fill(&in, &how, NULL, &f, &report), PBW_OK);
        CHECK(strcmp(stage, "improve") == 0);
        CHECK(report.improve.after.least > report.improve.before.least + 1);
        CHECK(report.inner.least >= report.improve.after.least);
        CHECK(f.tets.tet_count > 0 && f.tets.original[100] == 100);
        pbw_fill_free(&f);
        test_end();
    }
}

/* Points inside, for sizes, ratios and volumes: the same facets, and what was asked for where facets let it. */
static void test_inside(void)
{
    static const double centre[3] = { 0, 0, 0 }, seed[3] = { 0.0625, 0.375, 0.25 }, volumes[2] = { 2e-4, 0 };
    pbw_index region = 0;
    uint64_t key = 5;
    pbw_fill_options how;
    pbw_fill_report report;
    pbw_fill_input in;
    pbw_filled f;
    size_t counts[5] = { 0, 0, 0, 0, 0 }, large, i;
    int round;
    if (!test_begin("sizes inside")) {
        return;
    }
    for (round = 0; round < 10; round++) {
        memset(&how, 0, sizeof how);
        big.points = big.triangles = 0;
        add_star(300, 0.9, centre, 1, &key);
        (void)point(0.125, 0.25, 0.125);             /* of no triangle: it stays */
        in = input_of_big();
        how.conforming = how.split_flat = round > 4;
        how.size = round % 5 == 1 ? 0.15 : 0;
        how.size_at = round % 5 == 2 ? size_in_half : NULL;
        how.ratio = round % 5 == 3 ? 1.2 : 0;
        how.volume = round % 5 == 4 ? 1e-3 : 0;
        (void)fill_and_check(&in, &how, enclosed(&in));
        CHECK_EQUAL(pbw_fill(&in, &how, NULL, &f, &report), PBW_OK);
        CHECK((report.inside_points > 0) == (round % 5 > 0) && f.tets.original[300] == 300);
        counts[round % 5] = f.tets.tet_count;
        for (i = large = 0; i < f.tets.tet_count; i++) {
            large += how.volume > 0 && volume_at(&f, i) > how.volume;
        }
        CHECK(round != 4 || large == report.too_large);
        CHECK(large < f.tets.tet_count / 8);
        pbw_fill_free(&f);
    }
    CHECK(counts[1] > 2 * counts[0] && counts[2] > counts[0] && counts[2] < counts[1] && counts[3] > counts[0]);
    in.seeds = seed, in.seed_count = 1, in.seed_regions = &region;
    memset(&how, 0, sizeof how);
    how.volumes = volumes, how.volume_count = 2;
    for (; region < 2; region++) {                   /* the bound is for one of two numbers of regions */
        (void)fill_and_check(&in, &how, enclosed(&in));
        CHECK_EQUAL(pbw_fill(&in, &how, NULL, &f, NULL), PBW_OK);
        counts[region] = f.tets.tet_count;
        pbw_fill_free(&f);
    }
    CHECK(counts[0] > 2 * counts[1]);
    test_end();
}

static void test_cells(void)
{
    uint64_t key = 1000000;
    size_t n;
    for (n = 1; n <= 4; n++) {
        if (test_begin("%zu cells, even and uneven", n * n * n)) {
            size_t cells = make_cells(n, 0, &key);
            pbw_fill_input in = input_of_big();
            CHECK_EQUAL(fill_and_check(&in, NULL, (double)cells), cells);
            cells = make_cells(n, 0.15, &key);
            in = input_of_big();
            CHECK_EQUAL(fill_and_check(&in, NULL, (double)cells), cells);
            test_end();
        }
    }
}

static void test_shells(void)
{
    pbw_fill_options how;
    pbw_fill_input in;
    memset(&how, 0, sizeof how);
    if (test_begin("boxes in boxes")) {
        big.points = big.triangles = 0;
        add_box(-3, 3), add_box(-2, 2), add_box(-1, 1);
        in = input_of_big();
        CHECK_EQUAL(fill_and_check(&in, &how, 216 - 64 + 8), 2);
        how.nested = 1;
        CHECK_EQUAL(fill_and_check(&in, &how, 216), 3);
        how.nested = 0;
        how.outside = 1;
        CHECK_EQUAL(fill_and_check(&in, &how, -1), 4);
        how.outside = 0;
        test_end();
    }
    if (test_begin("boxes that touch in a corner, an edge, a side")) {
        size_t i;
        big.points = big.triangles = 0;
        add_box(0, 1), add_box(1, 2);
        in = input_of_big();
        CHECK_EQUAL(fill_and_check(&in, &how, 2), 2);
        for (i = 0; i < 8; i++) {
            big.x[8 + i][2] -= 1;
        }
        CHECK_EQUAL(fill_and_check(&in, &how, 2), 2);
        for (i = 0; i < 8; i++) {
            big.x[8 + i][1] -= 1;
        }
        {                                            /* the side in common is given twice */
            pbw_filled f;
            pbw_fill_report report;
            in = input_of_big();
            CHECK_EQUAL(pbw_fill(&in, &how, NULL, &f, &report), PBW_OK);
            CHECK_EQUAL(report.regions, 2);
            CHECK_EQUAL(report.doubles, 2);
            pbw_fill_free(&f);
        }
        test_end();
    }
}

static void test_seeds(void)
{
    static const double seeds[9] = { 0, 0, 0, 1.5, 0, 0, 2.5, 0, 0 };
    static const pbw_index regions[3] = { 7, PBW_NONE, 7 };
    if (test_begin("seeds of regions and holes")) {
        pbw_fill_input in;
        pbw_filled f;
        pbw_fill_report report;
        double volume = 0;
        size_t i;
        big.points = big.triangles = 0;
        add_box(-3, 3), add_box(-2, 2), add_box(-1, 1);
        in = input_of_big();
        in.seeds = seeds;
        in.seed_regions = regions;
        in.seed_count = 3;
        CHECK_EQUAL(pbw_fill(&in, NULL, NULL, &f, &report), PBW_OK);
        for (i = 0; i < f.tets.tet_count; i++) {
            const pbw_index *c = f.tets.corners + 4 * i;
            const double *x = f.tets.points;
            CHECK_EQUAL(f.tets.regions[i], 7);
            volume += volume_of(x + 3 * (size_t)c[0], x + 3 * (size_t)c[1], x + 3 * (size_t)c[2],
                                x + 3 * (size_t)c[3]);
        }
        CHECK(fabs(volume - 160) < 1e-9);
        pbw_fill_free(&f);
        test_end();
    }
    if (test_begin("seeds outside: of holes they are none, of regions an error, unless the outside is kept")) {
        static const double outside[9] = { 4, 0, 0, 1e9, 0, 0, 0, 0, 0 };
        const pbw_index of[3] = { PBW_NONE, PBW_NONE, 2 };
        pbw_fill_input in;
        pbw_fill_options how;
        pbw_fill_report report;
        pbw_filled f;
        memset(&how, 0, sizeof how);
        big.points = big.triangles = 0;
        add_box(-3, 3);
        in = input_of_big();
        in.seeds = outside;
        in.seed_regions = of;
        in.seed_count = 3;
        CHECK_EQUAL(fill_and_check(&in, NULL, 216), 1);
        in.seed_regions = of + 2;                    /* of the first alone */
        in.seed_count = 1;
        CHECK_EQUAL(pbw_fill(&in, NULL, NULL, &f, &report), PBW_DEGENERATE);
        CHECK_EQUAL(report.refusal, PBW_FILL_SEED);
        pbw_fill_free(&f);
        how.outside = 1;
        CHECK_EQUAL(fill_and_check(&in, &how, -1), 2);
        test_end();
    }
}

static void test_sheets(void)
{
    if (test_begin("sheets, wires and points in a box")) {
        static const pbw_index wire[2] = { 8, 9 };
        pbw_fill_input in;
        pbw_filled f;
        pbw_fill_report report;
        size_t i, walls = 0, found = 0, k;
        big.points = big.triangles = 0;
        add_box(0, 4);
        (void)point(0.5, 0.5, 3.5), (void)point(3.5, 3, 3.5), (void)point(2, 2, 0.25), (void)point(2, 0, 0);
        i = point(1, 1, 1);
        (void)point(3, 1, 1), (void)point(3, 3, 1.5), (void)point(1, 3, 2);
        triangle(i, i + 1, i + 2);
        triangle(i, i + 2, i + 3);
        in = input_of_big();
        in.segments = wire;
        in.segment_count = 1;
        CHECK_EQUAL(pbw_fill(&in, NULL, NULL, &f, &report), PBW_OK);
        CHECK_EQUAL(report.regions, 1);
        for (i = 0; i < f.facet_count; i++) {
            walls += f.facet_triangle[i] >= 12;
            CHECK(f.facet_triangle[i] < 12 || f.sides[2 * i + 1] == 0);
        }
        CHECK(walls >= 2);
        for (i = 0; i < f.tets.point_count; i++) {   /* points of no triangle are there: inside, on an edge */
            found += f.tets.original[i] == 10 || f.tets.original[i] == 11;
        }
        CHECK_EQUAL(found, 2);
        found = 0;
        for (i = 0; i < f.tets.tet_count && report.segment_points == 0; i++) {
            size_t ends = 0;
            for (k = 0; k < 4; k++) {
                const pbw_index o = f.tets.original[f.tets.corners[4 * i + k]];
                ends += o == 8 || o == 9;
            }
            found += ends == 2;
        }
        CHECK(found > 0 || report.segment_points > 0);
        pbw_fill_free(&f);
        test_end();
    }
}

/* Whether the tetrahedra have edges from one end of a wire to the other: between its points in order. */
static int has_wire(const pbw_filled *f, const double *a, const double *b)
{
    enum { MOST = 100 };
    double at[MOST], square = 0;
    pbw_index on[MOST];
    size_t count = 0, i, k, found = 0;
    for (k = 0; k < 3; k++) {
        square += (b[k] - a[k]) * (b[k] - a[k]);
    }
    for (i = 0; i < f->tets.point_count && count < MOST; i++) {
        const double *p = f->tets.points + 3 * i;
        double t = 0, off = 0;
        size_t j;
        for (k = 0; k < 3; k++) {
            t += (p[k] - a[k]) * (b[k] - a[k]) / square;
        }
        for (k = 0; k < 3; k++) {
            off = fmax(off, fabs(a[k] + t * (b[k] - a[k]) - p[k]));
        }
        if (off < 1e-12 && t > -1e-12 && t < 1 + 1e-12) {
            for (j = count++; j > 0 && at[j - 1] > t; j--) {
                at[j] = at[j - 1], on[j] = on[j - 1];
            }
            at[j] = t, on[j] = (pbw_index)i;
        }
    }
    for (i = 0; i + 1 < count; i++) {
        size_t tet, ends = 0;
        for (tet = 0; tet < f->tets.tet_count && ends < 2; tet++) {
            for (k = ends = 0; k < 4; k++) {
                ends += f->tets.corners[4 * tet + k] == on[i] || f->tets.corners[4 * tet + k] == on[i + 1];
            }
        }
        found += ends == 2;
    }
    return count > 1 && count < MOST && found == count - 1;
}

/* Wires that pass near boxes, some at places without doubles, stay through all that tetrahedra go through. */
static void test_wires(void)
{
    static const pbw_index wires[6] = { 0, 1, 1, 2, 2, 3 };
    static const double ends[4][3] = { { -1.3, -1.2, 0.1 }, { 1.4, 1.3, 0.3 }, { -1.2, 1.1, 0.7 },
                                       { 1.1, -1.3, -0.9 } };
    size_t round, i;
    if (!test_begin("wires near boxes")) {
        return;
    }
    for (round = 0; round < 4; round++) {
        pbw_fill_options how;
        pbw_fill_report report;
        pbw_fill_input in;
        pbw_filled f;
        memset(&how, 0, sizeof how);
        how.nested = 1;
        how.conforming = round == 1;
        how.size = round == 2 ? 0.5 : 0;
        how.improve.target = round == 3 ? 10 : 0;
        how.improve.passes = 3;
        big.points = big.triangles = 0;
        for (i = 0; i < 4; i++) {
            (void)point(ends[i][0], ends[i][1], ends[i][2]);
        }
        add_box(-2, 2), add_box(0.31, 0.77), add_box(-0.83, -0.27);
        for (i = 0; i < 8; i++) {
            big.x[12 + i][2] -= 0.63, big.x[20 + i][2] -= 0.47;
        }
        in = input_of_big();
        in.segments = wires, in.segment_count = 3;
        CHECK_EQUAL(pbw_fill(&in, &how, NULL, &f, &report), PBW_OK);
        CHECK(report.segment_points > 0 && report.refusal == PBW_FILL_FILLED && report.regions == 3);
        for (i = 0; i < 3; i++) {
            CHECK(has_wire(&f, ends[i], ends[i + 1]));
        }
        CHECK(!has_wire(&f, big.x[4], big.x[11]));   /* two corners of the box */
        if (f.tets.tet_count > 0) {
            result_copy c = copy_of(&f);
            const char *wrong = fault_of(&in, &c, 2, 64);
            if (!CHECK(wrong == NULL)) {
                test_say("%s", wrong);
            }
            free_copy(&c);
        }
        pbw_fill_free(&f);
        if (round < 3) {
            (void)fail_allocations(&in, &how, round == 0 ? 60 : 10);
        }
    }
    test_end();
}

/* A prism over a circle of `count` points: one cap is a fan, the other a zigzag. */
static void make_prism(size_t count)
{
    size_t i, low = 0, high = count - 1;
    big.points = big.triangles = 0;
    for (i = 0; i < 2 * count; i++) {
        const double angle = 2 * 3.141592653589793 * (double)(i / 2) / (double)count;
        (void)point(rounded(cos(angle)), rounded(sin(angle)), (double)(i % 2));
    }
    for (i = 0; i < count; i++) {
        const size_t next = (i + 1) % count;
        triangle(2 * i, 2 * next, 2 * next + 1);
        triangle(2 * i, 2 * next + 1, 2 * i + 1);
    }
    for (i = 1; i + 1 < count; i++) {
        triangle(0, 2 * i + 2, 2 * i);
    }
    for (i = 0; low + 1 < high; i++) {
        const size_t middle = i % 2 ? low + 1 : high - 1;
        triangle(2 * low + 1, 2 * middle + 1, 2 * high + 1);
        *(i % 2 ? &low : &high) = middle;
    }
}

/* A room with a wall that ends within its floor, in a larger box; points near the wall's foot, and in flat facets: in
   triangles, on edges between them. */
static void make_room(void)
{
    static const pbw_index floor[6][3] = { { 0, 1, 9 }, { 0, 9, 8 }, { 3, 2, 8 }, { 3, 8, 9 }, { 2, 0, 8 },
                                           { 1, 3, 9 } };
    size_t i;
    big.points = big.triangles = 0;
    add_box(0, 8);
    (void)point(2, 4, 0), (void)point(6, 4, 0), (void)point(6, 4, 3), (void)point(2, 4, 3);
    big.triangles -= 12;
    for (i = 0; i < 6; i++) {
        triangle(floor[i][0], floor[i][1], floor[i][2]);
    }
    i = big.triangles;
    add_box(-8, 16);                                 /* twelve triangles with the corners 12 to 19 */
    for (i += 2; i < 18; i++) {                      /* of the room: all but the floor */
        const pbw_index *t = big.t[i];
        triangle(t[0] - 12u, t[1] - 12u, t[2] - 12u);
    }
    triangle(8, 9, 10), triangle(8, 10, 11);
    (void)point(4, 4.0625, 0.03125), (void)point(4.5, 3.9375, 0.03125), (void)point(3.25, 4.03125, 0.0625);
    (void)point(4, 2, 0), (void)point(5, 5, 0);
    (void)point(4, 4, 8), (void)point(2, 2, 8), (void)point(6, 5, 8), (void)point(0, 4, 4), (void)point(0, 4, 5);
}

static void test_flat_facets(void)
{
    pbw_fill_options how;
    pbw_fill_report report;
    pbw_fill_input in;
    pbw_filled f;
    memset(&how, 0, sizeof how);
    if (test_begin("edges between coplanar triangles take no points")) {
        make_prism(48);
        in = input_of_big();
        CHECK_EQUAL(fill_and_check(&in, &how, enclosed(&in)), 1);
        CHECK_EQUAL(pbw_fill(&in, NULL, NULL, &f, &report), PBW_OK);
        CHECK_EQUAL(report.segment_points, 0);
        CHECK_EQUAL(report.facets, in.triangle_count);
        pbw_fill_free(&f);
        test_end();
    }
    if (test_begin("points that flips added inside join others")) {
        make_prism(300);
        in = input_of_big();
        CHECK_EQUAL(pbw_fill(&in, NULL, NULL, &f, &report), PBW_OK);
        CHECK_EQUAL(report.facets, in.triangle_count);
        CHECK(report.inner_points > 0 && report.inner_points < 8);
        pbw_fill_free(&f);
        test_end();
    }
    if (test_begin("points in flat facets, walls that end there")) {
        result_copy c;
        const char *wrong;
        size_t i, found = 0;
        make_room();
        in = input_of_big();
        how.nested = 1;
        CHECK_EQUAL(pbw_fill(&in, &how, NULL, &f, &report), PBW_OK);
        CHECK_EQUAL(report.refusal, PBW_FILL_FILLED);
        CHECK_EQUAL(report.regions, 2);
        CHECK(report.segment_points > 0);
        c = copy_of(&f);
        wrong = fault_of(&in, &c, 0, 24 * 24 * 24);
        if (!CHECK(wrong == NULL)) {
            test_say("%s", wrong);
        }
        for (i = 0; i < c.point_count; i++) {
            found += c.original[i] >= 20 && c.original[i] != PBW_NONE;
        }
        CHECK_EQUAL(found, 10);
        free_copy(&c);
        pbw_fill_free(&f);
        test_end();
    }
}

/* One of 24 kinds of damage. */
static void damage(result_copy *c, int kind)
{
    const size_t t = c->tet_count / 2;
    pbw_index *v = c->corners + 4 * t, swap;
    size_t inner = 0, i;
    while (c->neighbors[inner] == PBW_NONE || c->patches[inner] != PBW_NONE) {
        inner++;
    }
    switch (kind) {
    case 0: swap = v[0], v[0] = v[1], v[1] = swap; break;
    case 1: v[2] = v[3]; break;
    case 2: v[0] = (pbw_index)c->point_count; break;
    case 3: c->tet_count--; break;
    case 4: memcpy(c->corners, c->corners + 4, 4 * sizeof *c->corners); break;
    case 5: c->neighbors[inner] = PBW_NONE; break;
    case 6: c->neighbors[inner] = (c->neighbors[inner] + 1) % (pbw_index)c->tet_count; break;
    case 7: c->neighbors[inner] = (pbw_index)c->tet_count; break;
    case 8: c->points[0] += 1e-9; break;
    case 9: c->points[3 * (c->point_count - 1)] += 1e-9; break;
    case 10: c->original[0] = c->original[1]; break;
    case 11: swap = c->original[0], c->original[0] = c->original[1], c->original[1] = swap; break;
    case 12: c->regions[t]++; break;
    case 13: c->patches[inner] = 0; break;
    case 14: c->patches[c->facet_corners[0]] = PBW_NONE; break;
    case 15: c->facet_triangle[0] = (c->facet_triangle[0] + 1) % 20; break;
    case 16: c->patches[c->facet_corners[0]] = c->facet_triangle[0] = (c->facet_triangle[0] + 1) % 20; break;
    case 17: c->facet_count--; break;
    case 18: for (i = 0; i < 3; i++) { c->facets[i] = c->facets[3 + i]; } break;
    case 19: c->facet_corners[1] = c->facet_corners[0]; break;
    case 20: swap = c->facets[0], c->facets[0] = c->facets[1], c->facets[1] = swap; break;
    case 21: c->sides[0]++; break;
    case 22: c->sides[1] = 0; break;
    default: c->facet_triangle[0] = 4000000000u; break;
    }
}

static void test_checker(void)
{
    if (test_begin("the checker rejects 24 kinds of damage")) {
        static part m;
        pbw_fill_options how;
        pbw_fill_input in;
        pbw_filled f;
        int kind;
        size_t i;
        double volume;
        (void)part_make(PART_SPIKE + 2, 1, &m);      /* the plate: it needs points on segments */
        for (i = 0; i < 3 * m.points; i++) {
            m.x[i / 3][i % 3] = rounded(m.x[i / 3][i % 3]);
        }
        memset(&how, 0, sizeof how);
        how.split_flat = how.conforming = 1;
        in = input_of(m.x[0], m.points, m.t[0], m.triangles);
        volume = enclosed(&in);
        CHECK_EQUAL(pbw_fill(&in, &how, NULL, &f, NULL), PBW_OK);
        for (kind = -1; kind < 24; kind++) {
            result_copy c = copy_of(&f);
            size_t counts[2];
            const char *wrong;
            counts[0] = c.tet_count, counts[1] = c.facet_count;
            if (kind >= 0) {
                damage(&c, kind);
            }
            wrong = fault_of(&in, &c, 0, volume);
            if (!CHECK((wrong == NULL) == (kind < 0))) {
                test_say("kind %d: %s", kind, wrong == NULL ? "nothing" : wrong);
            }
            c.tet_count = counts[0], c.facet_count = counts[1];
            free_copy(&c);
        }
        pbw_fill_free(&f);
        test_end();
    }
}

static void expect(const pbw_fill_input *in, pbw_status status, int refusal)
{
    pbw_filled f;
    pbw_fill_report report;
    CHECK_EQUAL(pbw_fill(in, NULL, NULL, &f, &report), status);
    CHECK_EQUAL(report.refusal, refusal);
    CHECK(refusal == PBW_FILL_EMPTY || (report.fault_count > 0) == (refusal != PBW_FILL_FILLED));
    CHECK(status == PBW_OK || (f.memory == NULL && f.tets.tet_count == 0));
    pbw_fill_free(&f);
    pbw_fill_free(&f);
}

static void test_refusals(void)
{
    pbw_fill_input in;
    int k;
    if (test_begin("what is refused")) {
        static const double seed[3] = { 0, 0, 0 }, inside[6] = { 0.5, 0.25, 0.125, 0.25, 0.125, 0.5 };
        static const double side[3] = { 0.5, 0.75, 1.125 };
        static const pbw_index numbers[3] = { 1, 2, 2 }, holes[2] = { PBW_NONE, PBW_NONE };
        static const pbw_index wires[6] = { 8, 9, 8, 10, 11, 12 };
        CHECK_EQUAL(pbw_fill(NULL, NULL, NULL, NULL, NULL), PBW_ERROR_ARGUMENT);
        big.points = big.triangles = 0;
        in = input_of_big();
        expect(&in, PBW_DEGENERATE, PBW_FILL_EMPTY);
        add_box(-1, 1);
        in = input_of_big();
        expect(&in, PBW_OK, PBW_FILL_FILLED);
        in.point_count = 7;
        expect(&in, PBW_ERROR_ARGUMENT, PBW_FILL_FILLED);
        in.point_count = 8;
        in.triangle_count = 11;
        expect(&in, PBW_DEGENERATE, PBW_FILL_OPEN);
        in.triangle_count = 1;
        expect(&in, PBW_DEGENERATE, PBW_FILL_OPEN);
        in.triangle_count = 2;                       /* all in a plane */
        expect(&in, PBW_DEGENERATE, PBW_FILL_OPEN);
        in.triangle_count = 12;
        big.x[0][1] = sqrt(-1.0);
        expect(&in, PBW_ERROR_NOT_FINITE, PBW_FILL_FILLED);
        big.x[0][1] = HUGE_VAL;
        expect(&in, PBW_ERROR_NOT_FINITE, PBW_FILL_FILLED);
        big.x[0][1] = -1;
        {                                            /* a triangle without width, in a corner */
            const size_t middle = point(0, -1, -1);
            triangle(0, middle, 1);
            in = input_of_big();
            expect(&in, PBW_DEGENERATE, PBW_FILL_FLAT);
            big.t[12][1] = 1;                        /* without corners of its own */
            expect(&in, PBW_OK, PBW_FILL_FILLED);
        }
        big.points = big.triangles = 0;
        add_box(-1, 1), add_box(0, 2);
        in = input_of_big();
        expect(&in, PBW_DEGENERATE, PBW_FILL_CROSSING);
        big.points = big.triangles = 0;
        add_box(-1, 1), add_box(-2, 2);
        big.x[0][0] = -1 - ldexp(1, -40);            /* not by much */
        big.x[8][0] = -1, big.x[8][1] = -1, big.x[8][2] = -1;
        in = input_of_big();
        expect(&in, PBW_DEGENERATE, PBW_FILL_CROSSING);
        big.points = big.triangles = 0;
        add_box(0, 1);
        in = input_of_big();
        in.seeds = seed;                             /* in a corner */
        in.seed_count = 1;
        expect(&in, PBW_DEGENERATE, PBW_FILL_SEED);
        in.seeds = inside;                           /* of one region, with two numbers, or one */
        in.seed_count = 2;
        in.seed_regions = numbers;
        expect(&in, PBW_DEGENERATE, PBW_FILL_SEED);
        in.seed_regions = numbers + 1;
        expect(&in, PBW_OK, PBW_FILL_FILLED);
        in.seed_regions = holes;                     /* no side of the box is left */
        expect(&in, PBW_DEGENERATE, PBW_FILL_OPEN);
        in.seed_count = in.triangle_count = 0;
        expect(&in, PBW_DEGENERATE, PBW_FILL_EMPTY);
        big.points = big.triangles = 0;
        add_box(0, 2), add_box(0.5, 1.5);
        in = input_of_big();
        in.seeds = side;                             /* of the inner box */
        in.seed_count = 1;
        expect(&in, PBW_DEGENERATE, PBW_FILL_SEED);
        big.points = big.triangles = 0;
        add_box(0, 1);
        (void)point(0.25, 0.375, 0.5), (void)point(0.25, 0.5, 2), (void)point(0.75, 0.625, 0.5);
        (void)point(0.25, 0.625, 0.5), (void)point(0.75, 0.375, 0.5);
        in = input_of_big();
        in.segments = wires;                         /* through a side; two that cross */
        in.segment_count = 1;
        expect(&in, PBW_DEGENERATE, PBW_FILL_CROSSING);
        in.segments = wires + 2;
        in.segment_count = 2;
        expect(&in, PBW_DEGENERATE, PBW_FILL_CROSSING);
        in.segment_count = 1;
        expect(&in, PBW_OK, PBW_FILL_FILLED);
        test_end();
    }
    if (test_begin("refusals have words")) {
        for (k = PBW_FILL_FILLED; k <= PBW_FILL_POINTS_LEFT; k++) {
            const char *word = pbw_fill_refusal(k);
            CHECK(strlen(word) > 0 && strcmp(word, pbw_fill_refusal(-1)) != 0);
            CHECK(k == 0 || strcmp(word, pbw_fill_refusal(k - 1)) != 0);
        }
        test_end();
    }
}

static void test_magnitudes(void)
{
    if (test_begin("huge beside tiny")) {
        pbw_fill_input in;
        double *x = (double *)big.x;
        size_t i;
        big.points = big.triangles = 0;
        add_box(-1, 1);
        in = input_of_big();
        for (i = 0; i < 24; i++) {
            x[i] *= ldexp(1.5, 1023);                /* the box is wider than any double */
        }
        expect(&in, PBW_OK, PBW_FILL_FILLED);
        for (i = 0; i < 24; i++) {
            x[i] = x[i] > 0 ? 5e-324 : -5e-324;
        }
        expect(&in, PBW_OK, PBW_FILL_FILLED);
        big.x[0][0] = 1e308;
        expect(&in, PBW_DEGENERATE, PBW_FILL_TOO_FINE);
        for (i = 0; i < 24; i++) {
            x[i] = 1e15 + (i / 3 >> i % 3 & 1 ? 1 : 0);
        }
        expect(&in, PBW_OK, PBW_FILL_FILLED);
        test_end();
    }
}

static int stop_at(void *user, pbw_stage stage, double done)
{
    int *left = (int *)user;
    (void)stage;
    CHECK(done >= 0 && done <= 1);
    return --*left <= 0;
}

/* Counts the questions of the stage "facets", and cancels at one of all. */
typedef struct asked { const char *stage; long facets, left; } asked;

static int count_asked(void *user, pbw_stage stage, double done)
{
    asked *a = (asked *)user;
    (void)stage, (void)done;
    a->facets += strcmp(a->stage, "facets") == 0;
    return --a->left == 0;
}

/* A box of which two sides are grids of n by n squares. */
static void make_plates(size_t n)
{
    size_t i, j, side;
    big.points = big.triangles = 0;
    for (i = 0; i < 2 * (n + 1) * (n + 1); i++) {
        (void)point((double)(i / 2 % (n + 1)), (double)(i / 2 / (n + 1)), (double)(i % 2));
    }
    for (i = 0; i < n; i++) {
        for (j = 0; j < n; j++) {
            for (side = 0; side < 2; side++) {
                const size_t a = 2 * (i * (n + 1) + j) + side;
                triangle(a, a + 2, a + 2 * n + 4), triangle(a, a + 2 * n + 4, a + 2 * n + 2);
            }
        }
        for (side = 0; side < 4; side++) {
            const size_t line = side < 2 ? side * n : (side - 2) * n * (n + 1), step = side < 2 ? n + 1 : 1;
            const size_t a = 2 * (line + i * step), b = a + 2 * step;
            triangle(a, b, b + 1), triangle(a, b + 1, a + 1);
        }
    }
}

static void test_cancelling(void)
{
    if (test_begin("flat facets of many triangles ask for cancel")) {
        pbw_fill_input in;
        pbw_fill_options how;
        pbw_options options;
        pbw_filled f;
        meter memory;
        asked a = { "", 0, 0 };
        long k, calls;
        memset(&how, 0, sizeof how);
        memset(&options, 0, sizeof options);
        make_plates(40);
        in = input_of_big();
        meter_start(&memory, 0, 0);
        how.stage = &a.stage;
        options.threads = 1;
        options.resize = meter_resize;
        options.resize_user = &memory;
        options.progress = count_asked;
        options.progress_user = &a;
        CHECK_EQUAL(pbw_fill(&in, &how, &options, &f, NULL), PBW_OK);
        CHECK_EQUAL(f.facet_count, in.triangle_count);
        CHECK(a.facets > (long)in.triangle_count / 256);
        pbw_fill_free(&f);
        calls = -a.left;
        for (k = 1; k < calls; k += 1 + k / 8) {     /* the last question is asked when all is done */
            a.left = k;
            CHECK_EQUAL(pbw_fill(&in, &how, &options, &f, NULL), PBW_CANCELLED);
            CHECK(memory.blocks == 0 && memory.faults == 0 && f.memory == NULL);
        }
        test_end();
    }
}

static void test_memory(void)
{
    static const double centre[3] = { 0, 0, 0 };
    pbw_fill_input in;
    pbw_fill_options how;
    pbw_filled f;
    pbw_options options;
    meter memory;
    uint64_t key = 0;
    long k;
    memset(&how, 0, sizeof how);
    how.size = 0.3;
    memset(&options, 0, sizeof options);
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &memory;
    big.points = big.triangles = 0;
    add_star(40, 0.05, centre, 1, &key);
    in = input_of_big();
    if (test_begin("memory that fails, limits, cancelling")) {
        pbw_status status = PBW_OK;
        const size_t peak = fail_allocations(&in, &how, 20);
        meter_start(&memory, 0, 0);
        for (options.memory_limit = peak; options.memory_limit > 1000; options.memory_limit /= 2) {
            status = pbw_fill(&in, &how, &options, &f, NULL);
            CHECK(status == PBW_OK || status == PBW_ERROR_MEMORY);
            CHECK(memory.peak <= peak);
            pbw_fill_free(&f);
            CHECK(memory.blocks == 0 && memory.faults == 0);
        }
        CHECK_EQUAL(status, PBW_ERROR_MEMORY);
        options.memory_limit = 0;
        for (k = 1; k < 1000; k += 1 + k / 3) {
            int left = (int)k;
            options.progress = stop_at;
            options.progress_user = &left;
            status = pbw_fill(&in, &how, &options, &f, NULL);
            CHECK(status == (left <= 0 ? PBW_CANCELLED : PBW_OK));
            pbw_fill_free(&f);
            CHECK(memory.blocks == 0 && memory.faults == 0);
        }
        test_end();
    }
}

static void test_threads(void)
{
    static part m;
    size_t model;
    for (model = 0; model < 2; model++) {
        if (test_begin("the same bytes for any number of threads: %s", model == 0 ? "a wedge" : "cells")) {
            pbw_filled f[2];
            pbw_fill_input in;
            uint64_t key = 0;
            int i;
            if (model == 0) {
                (void)part_make(PART_WEDGE, 1, &m);
                in = input_of(m.x[0], m.points, m.t[0], m.triangles);
            } else {
                (void)make_cells(10, 0.2, &key);     /* threads share more than 512 facets */
                in = input_of_big();
            }
            for (i = 0; i < 2; i++) {
                pbw_options options;
                memset(&options, 0, sizeof options);
                options.threads = i == 0 ? 1 : 7;
                CHECK_EQUAL(pbw_fill(&in, NULL, &options, f + i, NULL), PBW_OK);
            }
            CHECK_EQUAL(f[0].tets.tet_count, f[1].tets.tet_count);
            CHECK_EQUAL(f[0].tets.point_count, f[1].tets.point_count);
            CHECK(memcmp(f[0].tets.corners, f[1].tets.corners, 4 * f[0].tets.tet_count * sizeof(pbw_index)) == 0);
            CHECK(memcmp(f[0].tets.points, f[1].tets.points, 3 * f[0].tets.point_count * sizeof(double)) == 0);
            CHECK(memcmp(f[0].facet_triangle, f[1].facet_triangle, f[0].facet_count * sizeof(pbw_index)) == 0);
            pbw_fill_free(f);
            pbw_fill_free(f + 1);
            test_end();
        }
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 60);
    test_checker();
    test_all_parts();
    test_few_points();
    test_stars();
    test_full_bits();
    test_wide_boxes();
    test_fine();
    test_no_doubles();
    test_needles();
    test_improvement();
    test_inside();
    test_cells();
    test_shells();
    test_seeds();
    test_sheets();
    test_wires();
    test_flat_facets();
    test_refusals();
    test_magnitudes();
    test_memory();
    test_cancelling();
    test_threads();
    return test_finish();
}
