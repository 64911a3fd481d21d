/* test_read.c: examples/lib/pbw_io.h reads the spellings that files have: polygons of every shape; each case with its
   counts, its sum of coordinates and its area, or with the words that refuse it. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "../pbw.h"
#define PBW_IO_IMPLEMENTATION
#include "../examples/lib/pbw_io.h"
#include "test.h"

typedef struct reading {
    const char *name, *text, *columns;
    int dim;                                /* of the cloud; 0: it is refused */
    size_t points, triangles;
    double sum, area;                       /* of all coordinates; of all triangles */
    /* a part of what is dropped or of the refusal; NULL: nothing is dropped */
    const char *words;
} reading;

static double area_of(const pbwio_cloud *c)
{
    double area = 0, a[3], b[3];
    size_t i, dim = (size_t)c->dim;
    int k;
    for (i = 0; i < c->triangle_count; i++) {
        const pbw_index *t = c->triangles + 3 * i;
        a[2] = b[2] = 0;
        for (k = 0; k < c->dim; k++) {
            a[k] = c->points[dim * t[1] + (size_t)k] - c->points[dim * t[0] + (size_t)k];
            b[k] = c->points[dim * t[2] + (size_t)k] - c->points[dim * t[0] + (size_t)k];
        }
        area += 0.5 * sqrt(pow(a[1] * b[2] - a[2] * b[1], 2) + pow(a[2] * b[0] - a[0] * b[2], 2)
                           + pow(a[0] * b[1] - a[1] * b[0], 2));
    }
    return area;
}

/* Whether the cloud or the refusal is what the case says. */
static int is_as_said(const reading *x, const pbwio_cloud *c, pbwio_status status, const char *text)
{
    double sum = 0;
    size_t i;
    if (status != PBWIO_OK || x->dim == 0) {
        return status != PBWIO_OK && x->dim == 0 && strstr(text, x->words) != NULL;
    }
    for (i = 0; i < c->count * (size_t)c->dim; i++) {
        sum += c->points[i];
    }
    return c->dim == x->dim && c->count == x->points && c->triangle_count == x->triangles
        && fabs(sum - x->sum) <= 1e-9 * fabs(x->sum) && fabs(area_of(c) - x->area) <= 1e-9 * x->area
        && (x->words == NULL ? c->dropped[0] == 0 : strstr(c->dropped, x->words) != NULL);
}

static void check_reading(const reading *x, const char *text, size_t size)
{
    pbwio_options options;
    pbwio_cloud c;
    pbwio_error error;
    pbwio_status status;
    memset(&options, 0, sizeof options);
    options.columns = x->columns;
    error.text[0] = 0;
    status = pbwio_read_memory(x->name, text, size, &options, &c, &error);
    if (!CHECK(is_as_said(x, &c, status, error.text))) {
        test_say("%.60s ...: %d, %zu, %zu, area %.17g; %s%s", text, c.dim, c.count, c.triangle_count, area_of(&c),
                 error.text, c.dropped);
    }
    pbwio_free(&c);
}

static void check_readings(const reading *all, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++) {
        check_reading(all + i, all[i].text, strlen(all[i].text));
    }
}

#define CHECK_ALL(all) check_readings(all, sizeof(all) / sizeof(all)[0])

/* ---- polygons ---- */

#define ARROW "v 0 0 0\nv 3 2 0\nv 0 5 0\nv 1 2 0\n"
#define CHANNEL "0 0 0\n7 0 0\n7 6 0\n5 6 0\n5 2 0\n2 2 0\n2 6 0\n0 6 0\n"

static const reading polygons[] = {
    { "arrow.obj", ARROW "f 1 2 3 4\n", NULL, 3, 4, 2, 13, 5, NULL },
    { "turned.obj", ARROW "f 4 3 2 1\n", NULL, 3, 4, 2, 13, 5, NULL },
    { "from_4.obj", ARROW "f 4 1 2 3\n", NULL, 3, 4, 2, 13, 5, NULL },
    { "points_last.obj", "f 1 2 3 4\n" ARROW, NULL, 3, 4, 2, 13, 5, NULL },
    { "upright_xz.obj", "v 0 0 0\nv 3 0 2\nv 0 0 5\nv 1 0 2\nf 1 2 3 4\n", NULL, 3, 4, 2, 13, 5, NULL },
    { "upright_yz.obj", "v 0 0 0\nv 0 3 2\nv 0 0 5\nv 0 1 2\nf 1 2 3 4\n", NULL, 3, 4, 2, 13, 5, NULL },
    { "tiny.obj", "v 0 0 0\nv 3e-300 2e-300 0\nv 0 5e-300 0\nv 1e-300 2e-300 0\nf 1 2 3 4\n", NULL, 3, 4, 2, 1.3e-299,
      0, NULL },
    { "huge.obj", "v 0 0 0\nv 3e70 2e70 0\nv 0 5e70 0\nv 1e70 2e70 0\nf 1 2 3 4\n", "1,2", 2, 4, 2, 1.3e71,
      5e140, NULL },
    { "channel.off", "OFF\n8 1 0\n" CHANNEL "8 0 1 2 3 4 5 6 7\n", NULL, 3, 8, 6, 56, 30, NULL },
    { "channel.ply", "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n" CHANNEL "8 7 6 5 4 3 2 1 0\n", NULL,
      3, 8, 6, 56, 30, NULL },
    { "plane.off", "OFF\n8 1 0\n" CHANNEL "8 2 3 4 5 6 7 0 1\n", "1,2", 2, 8, 6, 56, 30, NULL },
    { "halves.off", "OFF\n5 1 0\n0 0 0\n2 0 0\n4 0 0\n4 4 0\n0 4 0\n5 0 1 2 3 4\n", NULL, 3, 5, 3, 18, 16, NULL },
    { "convex.off", "OFF\n4 1 0\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n4 0 1 2 3\n", NULL, 3, 4, 2, 16, 16, NULL },
    { "comb.off", "OFF\n9 1 0\n0 0 0\n8 0 0\n8 4 0\n6 1 0\n5 4 0\n4 1 0\n3 4 0\n1 1 0\n0 4 0\n9 0 1 2 3 4 5 6 7 8\n",
      NULL, 3, 9, 7, 54, 20, NULL },
    { "quads.mesh", "MeshVersionFormatted 2\nDimension 2\nVertices 4\n0 0 0\n3 2 0\n0 5 0\n1 2 0\nQuadrilaterals 1\n"
      "1 2 3 4 0\nEnd\n", NULL, 2, 4, 2, 13, 5, NULL },
    { "quads.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 3 2 0\n3 0 5 0\n4 1 2 0\n$EndNodes\n"
      "$Elements\n1\n1 3 2 1 1 1 2 3 4\n$EndElements\n", NULL, 3, 4, 2, 13, 5, NULL },
    { "polygon.vtu", "<VTKFile type=\"UnstructuredGrid\"><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points>"
      "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 3 2 0 0 5 0 1 2 0</DataArray>"
      "</Points><Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>"
      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4</DataArray><DataArray type=\"Int32\" "
      "Name=\"types\" format=\"ascii\">7</DataArray></Cells></Piece></VTKFile>", NULL, 3, 4, 2, 13, 5, NULL },
    { "bow_tie.off", "OFF\n4 1 0\n0 0 0\n4 4 0\n4 0 0\n0 4 0\n4 0 1 2 3\n", NULL, 3, 4, 2, 16, 16,
      "outlines of 1 polygon: flat" },
    { "twice.off", "OFF\n4 1 0\n0 0 0\n4 0 0\n4 0 0\n0 4 0\n4 0 1 2 3\n", NULL, 3, 4, 2, 12, 8, "1 polygon" },
    { "flat.off", "OFF\n4 2 0\n0 0 0\n1 1 1\n2 2 2\n3 3 3\n4 0 1 2 3\n4 0 2 1 3\n", NULL, 3, 4, 4, 18, 0,
      "2 polygons" },
    { "touches.off", "OFF\n5 1 0\n0 0 0\n4 0 0\n4 4 0\n2 0 0\n0 4 0\n5 0 1 2 3 4\n", NULL, 3, 5, 3, 18, 16,
      "1 polygon" },
    { "keyhole.off", "OFF\n8 1 0\n0 0 0\n6 0 0\n6 6 0\n0 6 0\n2 2 0\n2 4 0\n4 4 0\n4 2 0\n"
      "10 0 1 2 3 0 4 5 6 7 4\n", NULL, 3, 8, 8, 48, 48, "1 polygon" },
    { "two_places.off", "OFF\n4 1 0\n0 0 0\n4 0 0\n0 0 0\n0 4 0\n4 0 1 2 3\n", NULL, 3, 4, 2, 8, 0, "1 polygon" }
};

static uint64_t next_random(void)
{
    static uint64_t state = 88172645463325252u;
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

static const double *corner_of(const double *xy, size_t n, size_t i)
{
    return xy + 2 * (i % n);
}

/* Whether edges i and k of a polygon have more in common than a corner that follows them both, by all pairs. */
static int edges_meet(const double *xy, size_t n, size_t i, size_t k)
{
    const double *a = corner_of(xy, n, i), *b = corner_of(xy, n, i + 1), *c = corner_of(xy, n, k);
    const double *d = corner_of(xy, n, k + 1);
    if (b == c || d == a) {
        const double *p = b == c ? a : c, *q = b == c ? b : a, *s = b == c ? d : b;
        return pbw_orient2(p, q, s) == 0 && (p[0] - q[0]) * (s[0] - q[0]) + (p[1] - q[1]) * (s[1] - q[1]) >= 0;
    }
    if (pbw_orient2(a, b, c) == 0 && pbw_orient2(a, b, d) == 0) {
        return fmax(fmin(a[0], b[0]), fmin(c[0], d[0])) <= fmin(fmax(a[0], b[0]), fmax(c[0], d[0]))
            && fmax(fmin(a[1], b[1]), fmin(c[1], d[1])) <= fmin(fmax(a[1], b[1]), fmax(c[1], d[1]));
    }
    return pbw_orient2(a, b, c) * pbw_orient2(a, b, d) <= 0 && pbw_orient2(c, d, a) * pbw_orient2(c, d, b) <= 0;
}

/* Random corners on a small lattice: a simple polygon gets triangles that turn as it does and have its area, any
   other one gets a word. */
static void test_random_polygons(void)
{
    double xy[32], twice;
    char text[1024];
    long trial, simple_ones = 0;
    for (trial = 0; trial < 10000; trial++) {
        size_t n = 4 + (size_t)(next_random() % 5), i, k, used;
        const size_t grid = 4 + (size_t)(next_random() % 6);
        int simple = 1, turned = 0;
        pbwio_options options = { PBWIO_OFF, 2, NULL, NULL, NULL, 0, NULL };
        pbwio_cloud c;
        used = (size_t)snprintf(text, sizeof text, "OFF\n%zu 1 0\n", n);
        for (i = 0; i < n; i++) {
            xy[2 * i] = (double)(next_random() % grid);
            xy[2 * i + 1] = (double)(next_random() % grid);
            used += (size_t)snprintf(text + used, sizeof text - used, "%g %g 0\n", xy[2 * i], xy[2 * i + 1]);
        }
        used += (size_t)snprintf(text + used, sizeof text - used, "%zu", n);
        for (i = 0, twice = 0; i < n; i++) {
            const double *a = corner_of(xy, n, i), *b = corner_of(xy, n, i + 1);
            used += (size_t)snprintf(text + used, sizeof text - used, " %zu", i);
            twice += a[0] * b[1] - a[1] * b[0];
            for (k = i + 1; k < n; k++) {
                simple &= !edges_meet(xy, n, i, k);
            }
        }
        if (!CHECK(pbwio_read_memory("a.off", text, used, &options, &c, NULL) == PBWIO_OK)) {
            continue;
        }
        for (i = 0; i < c.triangle_count; i++) {
            const pbw_index *t = c.triangles + 3 * i;
            turned += pbw_orient2(c.points + 2 * t[0], c.points + 2 * t[1], c.points + 2 * t[2]) != (twice > 0 ? 1
                : -1);
        }
        simple_ones += simple;
        if (!CHECK(c.triangle_count == n - 2 && (c.dropped[0] == 0) == simple
                   && (!simple || (turned == 0 && fabs(2 * area_of(&c) - fabs(twice)) < 1e-9)))) {
            test_say("%s: %d, %s", text, turned, c.dropped);
        }
        pbwio_free(&c);
    }
    CHECK(simple_ones > 1000);
}

/* Polygons of 20,000 corners: a star, a comb, a spiral; and one that crosses itself. */
static void test_large_polygons(void)
{
    const size_t n = 20000;
    char *text = (char *)malloc(64 * n);
    size_t i, used;
    int shape;
    for (shape = 0; shape < 4 && text != NULL; shape++) {
        pbwio_cloud c;
        double area[3];
        area[0] = 0.25 * (double)n * sin(8 * atan(1.0) / (double)n);
        area[1] = 0.5 * (double)n - 1;
        area[2] = 0;
        used = (size_t)sprintf(text, "OFF\n%zu 1 0\n", n);
        for (i = 0; i < n; i++) {
            const double t = 8 * atan(1.0) / (double)n * (double)i, half = (double)(i < n / 2 ? i : n - 1 - i);
            const double u = 1e-3 * half, r = 1 + u + (i < n / 2 ? 0 : 2), out = i % 2 ? 1 : 0.5;
            const double x = shape == 0 ? out * cos(t) : shape == 1 ? half : shape == 2 ? r * cos(u) : cos(7 * t);
            const double y = shape == 0 ? out * sin(t) : shape == 1 ? (fmod(half, 2) > 0 ? 1000 : 0) + (i < n / 2 ? 0
                : 1)
                           : shape == 2 ? r * sin(u) : sin(5 * t);
            used += (size_t)sprintf(text + used, "%.17g %.17g 0\n", x, y);
        }
        used += (size_t)sprintf(text + used, "%zu", n);
        for (i = 0; i < n; i++) {
            used += (size_t)sprintf(text + used, " %zu", shape == 1 ? n - 1 - i : i);
        }
        if (CHECK(pbwio_read_memory("a.off", text, used, NULL, &c, NULL) == PBWIO_OK)) {
            CHECK(c.triangle_count == n - 2 && (c.dropped[0] == 0) == (shape < 3));
            CHECK(shape > 1 || fabs(area_of(&c) - area[shape]) < 1e-6 * area[shape]);
            pbwio_free(&c);
        }
    }
    free(text);
}

static void test_polygons(void)
{
    CHECK_ALL(polygons);
    test_random_polygons();
    test_large_polygons();
}

/* ---- .stl ---- */

#define FACETS(facet, normal, outer, loop, vertex, endloop, endfacet) \
    facet " " normal " 0 0 1\n" outer " " loop "\n" \
    vertex " 0 0 0\n" vertex " 2 0 0\n" vertex " 0 2 0\n" endloop "\n" endfacet "\n" \
    facet " " normal " 0 0 1\n" outer " " loop "\n" \
    vertex " 2 0 0\n" vertex " 2 2 0\n" vertex " 0 2 0\n" endloop "\n" endfacet "\n"
#define LOWER FACETS("facet", "normal", "outer", "loop", "vertex", "endloop", "endfacet")
#define UPPER FACETS("FACET", "NORMAL", "OUTER", "LOOP", "VERTEX", "ENDLOOP", "ENDFACET")
#define TWO_WORDS FACETS("facet", "normal", "outer", "loop", "vertex", "end loop", "end facet")
#define IS_SQUARE 3, 6, 2, 12, 4, NULL

static const reading stl_texts[] = {
    { "plain.stl", "solid a\n" LOWER "endsolid a\n", NULL, IS_SQUARE },
    { "upper.stl", "SOLID MY CUBE WITH  SPACES\n" UPPER "ENDSOLID\n", NULL, IS_SQUARE },
    { "mixed.stl", "Solid a\n" FACETS("Facet", "Normal", "Outer", "Loop", "Vertex", "EndLoop",
      "EndFacet") "EndSolid\n",
      NULL, IS_SQUARE },
    { "indented.stl", "  solid my cube\n\t" LOWER "  endsolid\n", NULL, IS_SQUARE },
    { "tabs.stl", "\tsolid\ta\n" FACETS("\tfacet", "\tnormal", "\touter", "loop", "\t\tvertex\t", "\tendloop",
      "\tendfacet") "\tendsolid\n", NULL, IS_SQUARE },
    { "blank_lines.stl", "\n\n \nsolid a\n\n" LOWER "\n\nendsolid a\n\n", NULL, IS_SQUARE },
    { "mark.stl", "\xef\xbb\xbfsolid a\n" LOWER "endsolid a\n", NULL, IS_SQUARE },
    { "two_words.stl", "solid a\n" TWO_WORDS "end solid a\n", NULL, IS_SQUARE },
    { "upper_words.stl", "SOLID A\n" FACETS("FACET", "NORMAL", "OUTER", "LOOP", "VERTEX", "END LOOP", "END FACET")
      "END SOLID\n", NULL, IS_SQUARE },
    { "no_name.stl", "solid\n" LOWER "endsolid\n", NULL, IS_SQUARE },
    { "a_name_of_words.stl", "solid the vertex loop 1 2 3\n" LOWER "endsolid the vertex loop 1 2 3\n", NULL,
      IS_SQUARE },
    { "number_sign.stl", "solid part #7\n" LOWER "endsolid part #7\n", NULL, IS_SQUARE },
    { "umlaut.stl", "solid k\xc3\xb6rper\n" LOWER "endsolid k\xc3\xb6rper\n", NULL, IS_SQUARE },
    { "latin.stl", "solid k\xf6rper\n" LOWER "endsolid k\xf6rper\n", NULL, IS_SQUARE },
    { "no_end.stl", "solid a\n" LOWER, NULL, IS_SQUARE },
    { "no_head.stl", LOWER "endsolid\n", NULL, IS_SQUARE },
    { "several.stl", "solid a\n" LOWER "endsolid a\nsolid b\n" UPPER "endsolid b\n", NULL, 3, 12, 4, 24, 8, NULL },
    { "no_space.stl", "solid a\n" LOWER "endsolid a\nsolid b\n\nendsolid b\n", NULL, IS_SQUARE },
    { "one_line.stl", "solid a facet normal 0 0 1 outer loop vertex 0 0 0 vertex 2 0 0 vertex 0 2 0 endloop endfacet "
      "facet normal 0 0 1 outer loop vertex 2 0 0 vertex 2 2 0 vertex 0 2 0 endloop endfacet endsolid a", NULL,
      IS_SQUARE },
    { "old_mac.stl", "solid a\rfacet normal 0 0 1\router loop\rvertex 0 0 0\rvertex 2 0 0\rvertex 0 2 0\rendloop\r"
      "endfacet\rendsolid a\r", NULL, 3, 3, 1, 4, 2, NULL },
    { "windows.stl", "solid a\r\nfacet normal 0 0 1\r\nouter loop\r\nvertex 0 0 0\r\nvertex 2 0 0\r\nvertex 0 2 0\r\n"
      "endloop\r\nendfacet\r\nendsolid a\r\n", NULL, 3, 3, 1, 4, 2, NULL },
    { "exponents.stl", "solid a\nfacet normal -0 0 1\nouter loop\nvertex 0.0E+00 -0e0 0.\nvertex +2.0e+0 0 0\n"
      "vertex 0 .2E1 0\nendloop\nendfacet\nendsolid a\n", NULL, 3, 3, 1, 4, 2, NULL },
    { "normals_of_nan.stl",
      "solid a\nfacet normal nan nan nan\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 2 0\n"
      "endloop\nendfacet\nendsolid a\n", NULL, 3, 3, 1, 4, 2, NULL },
    { "in.unknown", " \n SOLID A\n" UPPER "ENDSOLID\n", NULL, IS_SQUARE },
    { "quads.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\n"
      "end loop\nend facet\n", NULL, 0, 0, 0, 0, 0, "quads.stl:8: a facet of 4 corners" },
    { "cut.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n", NULL, 0, 0,
      0, 0,
      0, "cut.stl:6: the file ends inside a facet" },
    { "empty.stl", "solid a\nendsolid a\n", NULL, 0, 0, 0, 0, 0, "the file has no points" }
};

/* A square of two triangles as binary .stl: head, count, more bytes behind. */
static void check_binary_stl(const char *head, char fill, unsigned count, size_t more, const reading *x)
{
    static const float corner[24] = { 0, 0, 1,  0, 0, 0,  2, 0, 0,  0, 2, 0,  0, 0, 1,  2, 0, 0,  2, 2, 0,  0, 2, 0 };
    char bytes[512];
    size_t i, k, at = 84;
    memset(bytes, 0, sizeof bytes);
    memset(bytes, fill, 80);
    memcpy(bytes, head, strlen(head));
    for (i = 0; i < 4; i++) {
        bytes[80 + i] = (char)(count >> 8 * i & 255);
    }
    for (i = 0; i < 24; i++) {
        uint32_t bits;
        memcpy(&bits, corner + i, sizeof bits);
        for (k = 0; k < 4; k++) {
            bytes[at++] = (char)(bits >> 8 * k & 255);
        }
        at += i % 12 == 11 ? 2 : 0;
    }
    check_reading(x, bytes, at + more);
}

static void test_stl(void)
{
    static const reading square = { "a.stl", NULL, NULL, IS_SQUARE };
    static const reading more = { "a.stl", NULL, NULL, 3, 6, 2, 12, 4, "6 bytes behind the triangles" };
    static const reading one = { "a.stl", NULL, NULL, 3, 3, 1, 4, 2, "50 bytes behind the triangles" };
    static const reading zero = { "a.stl", NULL, NULL, 3, 6, 2, 12, 4, "the number 0 of triangles in the head, 2" };
    static const reading none = { "a.stl", NULL, NULL, 3, 6, 2, 12, 4, "the number 4294967295 of triangles" };
    static const reading lacks = { "a.stl", NULL, NULL, 0, 0, 0, 0, 0,
        "3 triangles are announced, 100 bytes follow" };
    CHECK_ALL(stl_texts);
    check_binary_stl("binary", 0, 2, 0, &square);
    check_binary_stl("solid of a program", ' ', 2, 0, &square);
    check_binary_stl("solid of a program", ' ', 2, 6, &more);
    check_binary_stl("SOLID facet", ' ', 2, 6, &more);
    check_binary_stl("binary", 0, 2, 6, &more);
    check_binary_stl("solid", ' ', 1, 0, &one);
    check_binary_stl("solid", ' ', 0, 0, &zero);
    check_binary_stl("", 0, 0xffffffff, 0, &none);
    check_binary_stl("solid", ' ', 3, 0, &lacks);
}

/* ---- what is not read ---- */

static void test_refusals(void)
{
    static const char *const names[] = { "a.dxf", "a.shp", "a.STEP", "a.stp", "a.iges", "a.las", "a.laz", "a.e57",
        "a.3mf",
        "a.gltf", "a.glb", "a.fbx", "a.dae", "a.meshb", "a.bdf", "a.nas", "a.unv", "a.cgns", "a.med", "a.h5",
            "a.xdmf", "a.vtp", "a.pvtu",
        "b.c/a.kml.gz" };
    static const char *const texts[] = { "0 0\n1 0\n0 1\n", "{\"asset\": [[0, 0], [1, 1]]}", "0\nSECTION\n" };
    pbwio_cloud c;
    pbwio_error error;
    size_t i, k;
    for (i = 0; i < sizeof names / sizeof names[0]; i++) {
        for (k = 0; k < 3; k++) {
            CHECK(pbwio_read_memory(names[i], texts[k], strlen(texts[k]), NULL, &c, &error) == PBWIO_ERROR_ARGUMENT);
            CHECK(strstr(error.text, ": files with this ending are not read: ") != NULL);
            CHECK(strstr(error.text, "; formats that are read: .obj .ply") != NULL);
            CHECK(strstr(error.text, " .json .geojson") != NULL && c.count == 0);
        }
    }
    CHECK(pbwio_read_memory("a.what", texts[0], strlen(texts[0]), NULL, &c, &error) == PBWIO_OK && c.count == 3);
    pbwio_free(&c);
    CHECK(pbwio_read_memory("a.dxf/points", texts[0], strlen(texts[0]), NULL, &c, &error) == PBWIO_OK
        && c.count == 3);
    pbwio_free(&c);
    CHECK(pbwio_read_memory("a.what", "1 2\n\0\1", 6, NULL, &c, &error) == PBWIO_ERROR_ARGUMENT);
    CHECK(strstr(error.text, "a.what: the content is binary and no table; formats that are read: .obj") != NULL);
    CHECK(pbwio_read_memory("a.csv", "\x89HDF\r\n\x1a\n\0\0", 10, NULL, &c, &error) == PBWIO_ERROR_ARGUMENT);
}

/* ---- data that a cloud has no place for ---- */

static const reading unkept[] = {
    { "colours.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nproperty int part\n"
      "element edge 1\nproperty int a\nend_header\n0 0 1 0 9\n2 0 1 0 9\n0 2 1 0 9\n3 0 1 2 7\n0\n", NULL, 3, 3, 1, 7, 2,
      "data: red, part, edge" },
    { "chosen.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float w\n"
      "end_header\n1 2 3\n", "x,w", 2, 1, 0, 4, 0, NULL },
    { "colours.off", "COFF\n3 1 0\n0 0 1 9 9 9 9\n2 0 1 9 9 9 9\n0 2 1 9 9 9 9\n3 0 1 2\n", NULL, 3, 3, 1, 7, 2,
      "colours, normals, texture" },
    { "both.obj", "v 0 0 1\nv 2 0 1\nv 0 2 1\nusemtl a\ng one\nf 1 2 3\nusemtl b\ng two\nf 1 3 2\n", NULL, 3, 3, 2, 7, 4,
      "groups of faces but those by usemtl" },
    { "one_by_g.obj", "v 0 0 1\nv 2 0 1\nv 0 2 1\nusemtl a\ng one\nf 1 2 3\ng two\nf 1 3 2\n", NULL, 3, 3, 2, 7, 4, NULL },
    { "ridges.mesh", "MeshVersionFormatted 2\nDimension 2\nVertices\n3\n0 0 0\n2 0 0\n0 2 0\nTriangles\n1\n1 2 3 0\n"
      "Ridges\n1\n1\nCorners\n1\n2\nEnd\n", NULL, 2, 3, 1, 4, 2, "data: Ridges, Corners" },
    { "fields.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 1\n2 2 0 1\n3 0 2 1\n$EndNodes\n$Elements\n1\n"
      "1 2 0 1 2 3\n$EndElements\n$Comments\nno data\n$EndComments\n$NodeData\n1\n\"T\"\n$EndNodeData\n", NULL, 3, 3, 1, 7,
      2, "data: $NodeData" },
    { "fields.vtu", "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"3\" NumberOfCells=\"1\">"
      "<PointData><DataArray type=\"Float64\" Name=\"T\" format=\"ascii\">1 2 3</DataArray>"
      "<DataArray type=\"UInt32\" Name=\"id\" format=\"ascii\">0 1 2</DataArray></PointData>"
      "<CellData><DataArray type=\"Float64\" Name=\"region\" format=\"ascii\">1.5</DataArray></CellData><Points>"
      "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 1 2 0 1 0 2 1</DataArray></Points><Cells>"
      "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>"
      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray>"
      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>",
      NULL, 3, 3, 1, 7, 2, "data: T, region" }
};

static void test_unkept(void)
{
    CHECK_ALL(unkept);
}

/* ---- .gz ---- */

typedef struct content { char *bytes; size_t size; } content;

static void emit_content(void *user, FILE *file)
{
    const content *c = (const content *)user;
    fwrite(c->bytes, 1, c->size, file);
}

/* Nothing, a byte, random bytes, zeros, text that repeats from near and from far, around the size of a block. */
static void test_packing(void)
{
    static const size_t sizes[] = { 0, 1, 3, 4, 5, 258, 259, 1000, 65535, 65536, 65537, 131072, 200001 };
    char path[] = "/tmp/pbw-read-XXXXXX.gz", command[96];
    const int file = mkstemps(path, 3);
    size_t i, k, size;
    int kind;
    if (!CHECK(file >= 0)) {
        return;
    }
    close(file);
    for (kind = 0; kind < 5; kind++) {
        for (i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            content c;
            char *back;
            c.size = sizes[i];
            c.bytes = (char *)malloc(c.size + 1);
            for (k = 0; k < c.size; k++) {
                const int x = (int)(next_random() % 256);
                c.bytes[k] = (char)(kind == 0 ? x : kind == 1 ? 0 : kind == 2 ? '0' + x % 10
                                    : kind == 3 ? "abcdefgh\n"[k * k % 97 % 9] : k < 40000 ? x : c.bytes[k - 32768]);
            }
            CHECK(pbwio_save(path, emit_content, &c, NULL, NULL) == PBWIO_OK);
            back = pbwio_load(path, NULL, &size, NULL);
            CHECK(back != NULL && size == c.size && (size == 0 || memcmp(back, c.bytes, size) == 0));
            free(back);
            snprintf(command, sizeof command, "gzip -t %s", path);
            CHECK(system(command) == 0);
            free(c.bytes);
        }
    }
    unlink(path);
}

/* A mesh comes back from a packed file, which is smaller. */
static void test_packed_mesh(void)
{
    char path[] = "/tmp/pbw-read-XXXXXX.msh2.gz";
    const int file = mkstemps(path, 8);
    double points[3 * 500];
    pbw_mesh mesh;
    pbwio_cloud c;
    struct stat info;
    size_t i;
    memset(&mesh, 0, sizeof mesh);
    for (i = 0; i < 1500; i++) {
        points[i] = (double)(next_random() % 1000) / 8;
    }
    CHECK(file >= 0 && close(file) == 0 && pbwio_format_of(path) == PBWIO_MSH2);
    CHECK(pbw_triangulate(3, points, NULL, 500, NULL, &mesh) == PBW_OK);
    if (CHECK(pbwio_write(path, &mesh, NULL, NULL) == PBWIO_OK)) {
        pbwio_options options = { PBWIO_MSH, 0, NULL, NULL, NULL, 0, NULL };
        CHECK(stat(path, &info) == 0 && (size_t)info.st_size < 16 * mesh.simplex_count);
        CHECK(pbwio_read(path, &options, &c, NULL) == PBWIO_OK && c.count == 500);
        CHECK(c.tetrahedron_count == mesh.simplex_count
              && memcmp(c.points, points, sizeof points) == 0
              && memcmp(c.tetrahedra, mesh.simplices, 4 * mesh.simplex_count * sizeof(pbw_index)) == 0);
        pbwio_free(&c);
    }
    pbw_free(&mesh);
    unlink(path);
}

static void test_gzip(void)
{
    test_packing();
    test_packed_mesh();
}

/* ---- columns of tables ---- */

/* taken: or the refusal; dim 0 */
typedef struct header { const char *names, *taken; int dim; double sum; } header;

/* Over the rows 9,1,2,3 and 8,4,5,6, with a separator. */
static const header headers[] = {
    { "id,x,y,z", "", 3, 21 }, { "fid,X,Y,name", "", 2, 12 },
    { "id,easting,northing,height", "x = column 2 (easting), y = column 3 (northing), z = column 4 (height)", 3, 21 },
    { "n,Easting,Northing,Elevation", "z = column 4 (Elevation)", 3, 21 },
    { "OBJECTID,lon,lat,alt", "x = column 2 (lon), y = column 3 (lat), z = column 4 (alt)", 3, 21 },
    { "pop,longitude,latitude,w", "x = column 2 (longitude), y = column 3 (latitude)", 2, 12 },
    { "a,Latitude,Longitude,w", "x = column 3 (Longitude), y = column 2 (Latitude)", 2, 12 },
    { "a,lat,lng,b", "x = column 3 (lng)", 2, 12 }, { "FID,X_COORD,Y_COORD,k", "x = column 2 (X_COORD)", 2, 12 },
    { "a,POINT_X,POINT_Y,POINT_Z", "z = column 4 (POINT_Z)", 3, 21 }, { "a,coord_x,coord_y,b", "column 2 (coord_x)",
      2, 12 },
    { "a,xcoord,ycoord,zcoord", "z = column 4 (zcoord)", 3, 21 }, { "a,x (m),y (m),z (m)", "z = column 4 (z (m))", 3,
      21 },
    { "a,x [m],y [m],b", "x = column 2 (x [m])", 2, 12 }, { "a,x_mm,y_mm,z_mm", "z = column 4 (z_mm)", 3, 21 },
    { "a,\"x\",\"y\",\"z\"", "", 3, 21 }, { "a,\"X Coordinate\",\"Y Coordinate\",b", "x = column 2 (X Coordinate)",
      2, 12 },
    { "a,Points:0,Points:1,Points:2", "z = column 4 (Points:2)", 3, 21 }, { "a,East,North,b", "column 2 (East)", 2,
      12 },
    { "a,E,N,z", "x = column 2 (E), y = column 3 (N), z = column 4 (z)", 3, 21 },
    { "a,utm_easting,utm_northing,b", "column 2 (utm_easting)", 2, 12 }, { "a,x,y,elev", "z = column 4 (elev)", 3,
      21 },
    { "id,p,q,r", "x = column 2 (p), y = column 3 (q), z = column 4 (r): no known names, the first that are no ids",
      3, 21 },
    { ",p,q,r", "x = column 2 (p)", 3, 21 }, { "Unnamed: 0,p,q,r", "x = column 2 (p)", 3, 21 },
    { "p,id,q,r", "x = column 1 (p), y = column 3 (q), z = column 4 (r): no known names", 3, 33 },
    { "point_id,p,q,station_id", "", 2, 12 },
    { "easting,northing,lon,lat",
      "a.csv:1: several columns may be x and y: easting (1), northing (2), lon (3), lat (4)", 0,
      0 },
    { "x (m),x (ft),y (m),z", "several columns may be x and y: x (m) (1), x (ft) (2), y (m) (3); choose", 0, 0 },
    { "x,y,height,elevation", "several columns may be z: height (3), elevation (4); choose by names or numbers", 0,
      0 },
    { "lon,longitude,lat,a", "several columns may be x and y: lon (1), longitude (2), lat (3)", 0, 0 },
    { "x,y,X,Y", "several columns may be x and y", 0, 0 }
};

static void test_headers(void)
{
    static const char separators[] = ",;\t";
    char text[256], *s;
    size_t i, k;
    for (i = 0; i < sizeof headers / sizeof headers[0]; i++) {
        for (k = 0; k < 3; k++) {
            const header *h = headers + i;
            const int spread = k == 2 && (strchr(h->names, ' ') != NULL || h->names[0] == ',' || strchr(h->names,
                '"'));
            reading x = { "a.csv", NULL, NULL, 0, 2, 0, 0, 0, NULL };
            pbwio_cloud c;
            pbwio_error error;
            snprintf(text, sizeof text, "%s\n9,1,2,3\n8,4,5,6\n", h->names);
            for (s = text; *s != 0; s++) {
                *s = *s == ',' ? separators[k] : *s;
            }
            x.dim = h->dim;
            x.sum = h->sum;
            x.words = h->dim == 0 ? h->taken : NULL;
            if (spread) {                                            /* blanks set columns apart there */
                continue;
            }
            check_reading(&x, text, strlen(text));
            if (h->dim != 0 && CHECK(pbwio_read_memory("a.csv", text, strlen(text), NULL, &c, &error) == PBWIO_OK)) {
                if (!CHECK(strstr(c.taken, h->taken) != NULL && (*h->taken != 0 || h->names[0] == 'p'
                    || *c.taken == 0))) {
                    test_say("%s: %s", h->names, c.taken);
                }
                pbwio_free(&c);
            }
        }
    }
}

/* Columns by name and number, all, with a weight among them; such as are not there or no numbers. */
static void test_kept_columns(void)
{
    static const char table[] = "id,easting,northing,height,mass,kind\n7,1,2,3,0.5,rock\n8,4,5,6,0.25,sand\n";
    static const struct { const char *keep, *weight; size_t count; double sum; const char *words; } cases[] = {
        { "mass", NULL, 1, 0.75, "" }, { "5,id", NULL, 2, 15.75, "" }, { "*", NULL, 2, 15.75, "1 column of text" },
        { "*", "mass", 1, 15, "1 column of text" }, { "height", NULL, 1, 9, "" }, { "", NULL, 0, 0, "" },
        { "kind", NULL, 0, -1, "a.csv:2: column 6, \"rock\", is kept and not a finite number" },
        { "what", NULL, 0, -1, "a.csv:1: there is no column \"what\"; there are id, easting" },
        { "9", NULL, 0, -1, "a.csv:1: column 9 is needed, there are 6" }
    };
    size_t i, k;
    for (i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        pbwio_options options = { PBWIO_AUTO, 0, NULL, NULL, NULL, 0, NULL };
        pbwio_cloud c;
        pbwio_error error;
        double sum = 0;
        options.keep = cases[i].keep;
        options.weight = cases[i].weight;
        if (pbwio_read_memory("a.csv", table, sizeof table - 1, &options, &c, &error) != PBWIO_OK) {
            CHECK(cases[i].sum < 0 && strstr(error.text, cases[i].words) == error.text);
            continue;
        }
        for (k = 0; k < c.column_count; k++) {
            sum += c.columns[k].values[0] + c.columns[k].values[1];
        }
        CHECK(c.column_count == cases[i].count && fabs(sum - cases[i].sum) < 1e-12);
        CHECK(strcmp(c.dropped, cases[i].words) == 0 && c.dim == 3 && c.points[3] > 3.5);
        CHECK(i != 1 || (strcmp(c.columns[0].name, "id") == 0 && strcmp(c.columns[1].name, "mass") == 0));
        pbwio_free(&c);
    }
}

static void test_tables(void)
{
    test_headers();
    test_kept_columns();
}

/* ---- .json ---- */

#define IS_TRIANGLE 2, 3, 0, 5, 0, NULL
#define LIST "[[0,0],[2,0],[0,3]]"
#define OBJECTS "[{\"x\":0,\"y\":0},{\"x\":2,\"y\":0},{\"x\":0,\"y\":3}]"
#define EDGES "[[0,1],[1,2],[2,0],[0,2]]"
#define GEO(type, coordinates) \
    "{\"type\":\"Feature\",\"properties\":{\"points\":[[7,7]]},\"geometry\":" \
    "{\"type\":\"" type "\",\"coordinates\":" coordinates "}}"

static const reading jsons[] = {
    { "bare.json", LIST, NULL, IS_TRIANGLE },
    { "points.json", "{\"points\":" LIST ",\"edges\":" EDGES "}", NULL, IS_TRIANGLE },
    { "edges_first.json", "{\"edges\":" EDGES ",\"points\":" LIST "}", NULL, IS_TRIANGLE },
    { "vertices.json", "{\"vertices\":" LIST ",\"faces\":[[0,1,2]]}", NULL, IS_TRIANGLE },
    { "upper.json", "{\"Vertices\":" LIST ",\"Triangles\":[[0,1,2]]}", NULL, IS_TRIANGLE },
    { "positions.json", "{\"positions\":" LIST ",\"cells\":[[0,1,2]]}", NULL, IS_TRIANGLE },
    { "nodes.json", "{\"nodes\":" LIST ",\"links\":" EDGES "}", NULL, IS_TRIANGLE },
    { "coordinates.json", "{\"coordinates\":" LIST ",\"indices\":[[0,1,2]]}", NULL, IS_TRIANGLE },
    { "nested.json", "{\"mesh\":{\"geometry\":{\"points\":" LIST "},\"topology\":{\"arcs\":" EDGES "}}}", NULL,
      IS_TRIANGLE },
    { "other_name.json", "{\"sites\":" LIST ",\"name\":\"a\"}", NULL, IS_TRIANGLE },
    { "with_edges.json", "{\"sites\":" LIST ",\"edges\":" EDGES "}", NULL, IS_TRIANGLE },
    { "known_and_not.json", "{\"sizes\":[[1,2]],\"points\":" LIST "}", NULL, IS_TRIANGLE },
    { "objects.json", "{\"nodes\":" OBJECTS ",\"links\":[{\"source\":0,\"target\":1}]}", NULL, IS_TRIANGLE },
    { "objects_bare.json", OBJECTS, NULL, IS_TRIANGLE },
    { "labels_too.json", "{\"nodes\":" OBJECTS ",\"labels\":[{\"x\":9,\"y\":9}]}", NULL, IS_TRIANGLE },
    { "members.json", "[{\"id\":1,\"at\":[0,0]},{\"id\":2,\"at\":[2,0]},{\"id\":3,\"at\":[0,3]}]", NULL,
      IS_TRIANGLE },
    { "members_and_boxes.json", "[{\"at\":[0,0],\"bbox\":[1,1,2,2]},{\"at\":[2,0]},{\"at\":[0,3]}]", NULL,
      IS_TRIANGLE },
    { "by_name.json", "{\"a\":[0,0],\"b\":[2,0],\"c\":[0,3]}", NULL, IS_TRIANGLE },
    { "nodes_by_name.json", "{\"nodes\":{\"a\":[0,0],\"b\":[2,0],\"c\":[0,3]},\"edges\":" EDGES "}", NULL,
      IS_TRIANGLE },
    { "chosen.json", "{\"points\":[[9,9],[8,8]],\"vertices\":" LIST "}", "vertices", IS_TRIANGLE },
    { "chosen_columns.json", "{\"points\":[[9,9],[8,8]],\"vertices\":[[5,0,0],[5,2,0],[5,0,3]]}", "vertices:2,3",
      IS_TRIANGLE },
    { "chosen_members.json", "{\"a\":[{\"u\":0,\"v\":0},{\"u\":2,\"v\":3}],\"b\":[{\"u\":1,\"v\":1}]}", "a:u,v", 2,
      2, 0, 5, 0,
      NULL },
    { "polygon.geojson", GEO("Polygon", "[[[0,0],[2,0],[0,3],[0,0]]]"), NULL, IS_TRIANGLE },
    { "hole.geojson", GEO("Polygon", "[[[0,0],[9,0],[0,9],[0,0]],[[1,1],[2,1],[1,2],[1,1]]]"), NULL, 2, 6, 0, 26, 0,
      NULL },
    { "line.geojson", GEO("LineString", "[[0,0],[2,0],[0,3]]"), NULL, IS_TRIANGLE },
    { "lines.geojson", GEO("MultiLineString", "[[[0,0],[2,0]],[[0,3],[1,1]]]"), NULL, 2, 4, 0, 7, 0, NULL },
    { "many.geojson", GEO("MultiPoint", LIST), NULL, IS_TRIANGLE },
    { "parts.geojson", GEO("MultiPolygon", "[[[[0,0],[1,0],[0,1],[0,0]]],[[[0,0],[0,-1],[-1,0],[0,0]]]]"), NULL,
      2, 6, 0, 0, 0, NULL },
    { "two.json", "{\"points\":" LIST ",\"vertices\":" EDGES "}", NULL, 0, 0, 0, 0, 0,
      "several lists may be the points: points (3), vertices (4); choose one by columns "
      "(--columns NAME or NAME:x,y)" },
    { "unknown.json", "{\"a\":" LIST ",\"b\":" EDGES "}", NULL, 0, 0, 0, 0, 0,
      "several lists may be the points: a (3), b (4)" },
    { "columns.json", "{\"x\":[0,1,2],\"y\":[3,4,5]}", "what", 0, 0, 0, 0, 0,
      "no list of points is named so; there are x (1)" },
    { "only_edges.json", "{\"edges\":" EDGES "}", NULL, 0, 0, 0, 0, 0, "no points" }
};

static void test_json(void)
{
    static const char rings[] = GEO("Polygon", "[[[0,0],[2,0],[0,3],[0,0]]]");
    pbwio_options options = { PBWIO_AUTO, 0, NULL, NULL, NULL, PBWIO_CLOSED_RINGS, NULL };
    pbwio_cloud c;
    CHECK_ALL(jsons);
    CHECK(pbwio_read_memory("a.geojson", rings, sizeof rings - 1, &options, &c, NULL) == PBWIO_OK && c.count == 4);
    pbwio_free(&c);
}

/* ---- .vtk ---- */

typedef struct vtk_file { char bytes[4096]; size_t size; int binary; } vtk_file;

static void vtk_line(vtk_file *f, const char *text)
{
    f->size += (size_t)snprintf(f->bytes + f->size, sizeof f->bytes - f->size, "%s\n", text);
}

/* Numbers of 1, 4 or 8 bytes, the highest first; 'd' doubles, 'f' floats, 'i' integers. */
static void vtk_numbers(vtk_file *f, int type, size_t size, const double *value, size_t count)
{
    size_t i, k;
    for (i = 0; i < count; i++) {
        uint64_t bits = (uint64_t)(int64_t)value[i];
        const float single = (float)value[i];
        uint32_t narrow;
        memcpy(&narrow, &single, sizeof narrow);
        bits = type == 'f' ? narrow : bits;
        if (type == 'd') {
            memcpy(&bits, value + i, sizeof bits);
        }
        for (k = 0; k < size && f->binary; k++) {
            f->bytes[f->size++] = (char)(bits >> 8 * (size - 1 - k) & 255);
        }
        if (!f->binary) {
            f->size += (size_t)snprintf(f->bytes + f->size, 32, i % 5 == 4 ? "%g\n" : "%g ", value[i]);
        }
    }
    vtk_line(f, "");
}

/* Two tetrahedra, an arrow of four corners and a line as a grid, or the arrow alone as PolyData; version: "2.0" to
   "5.1"; extras: arrays before the one of regions. */
static void make_vtk(vtk_file *f, const char *version, int binary, int grid, int extras)
{
    static const double points[] = { 0, 0, 0, 3, 2, 0, 0, 5, 0, 1, 2, 0, 0, 0, 1, 0, 0, -1 };
    static const double old[] = { 4, 0, 1, 3, 4, 4, 0, 3, 1, 5, 4, 0, 1, 2, 3, 2, 0, 1 }, kinds[] = { 10, 10, 7, 3 };
    static const double offsets[] = { 0, 4, 8, 12, 14 }, corners[] = { 0, 1, 3, 4, 0, 3, 1, 5, 0, 1, 2, 3, 0, 1 };
    static const double regions[] = { 7, 9, 7, 5 }, arrow[] = { 4, 0, 1, 2, 3 }, values[] = { 1, 2, 3, 4, 5, 6, 7, 8,
        9, 10,
        11, 12, 13, 14, 15, 16, 17, 18 };
    const int fresh = version[0] == '5';
    char head[64];
    f->size = 0;
    f->binary = binary;
    snprintf(head, sizeof head, "# vtk DataFile Version %s", version);
    vtk_line(f, head);
    vtk_line(f, "POINTS 3 of no section: a title");
    vtk_line(f, binary ? "BINARY" : "ASCII");
    vtk_line(f, grid ? "DATASET UNSTRUCTURED_GRID" : "DATASET POLYDATA");
    if (extras) {
        vtk_line(f, "FIELD FieldData 1\nTIME 1 1 double");
        vtk_numbers(f, 'd', 8, values, 1);
    }
    vtk_line(f, extras ? "POINTS 6 double" : "POINTS 6 float");
    vtk_numbers(f, extras ? 'd' : 'f', extras ? 8 : 4, points, 18);
    if (extras && fresh) {
        vtk_line(f, "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 5\n");
    }
    vtk_line(f, grid ? fresh ? "CELLS 5 14" : "CELLS 4 18" : fresh ? "POLYGONS 2 4" : "POLYGONS 1 5");
    if (fresh) {
        vtk_line(f, extras ? "OFFSETS vtktypeint64" : "OFFSETS vtktypeint32");
        vtk_numbers(f, 'i', extras ? 8 : 4, offsets, grid ? 5 : 2);
        vtk_line(f, extras ? "CONNECTIVITY vtktypeint64" : "CONNECTIVITY vtktypeint32");
        vtk_numbers(f, 'i', extras ? 8 : 4, grid ? corners : arrow + 1, grid ? 14 : 4);
    } else {
        vtk_numbers(f, 'i', 4, grid ? old : arrow, grid ? 18 : 5);
    }
    if (grid) {
        vtk_line(f, "CELL_TYPES 4");
        vtk_numbers(f, 'i', 4, kinds, 4);
    }
    if (extras) {
        vtk_line(f, "POINT_DATA 6\nSCALARS mass double 1\nLOOKUP_TABLE default");
        vtk_numbers(f, 'd', 8, values, 6);
        vtk_line(f, "VECTORS flow float");
        vtk_numbers(f, 'f', 4, values, 18);
        vtk_line(f, grid ? "CELL_DATA 4\nSCALARS id unsigned_char" : "CELL_DATA 1\nSCALARS id unsigned_char");
        vtk_line(f, "LOOKUP_TABLE default");
        vtk_numbers(f, 'i', 1, values, grid ? 4 : 1);
        vtk_line(f, grid ? "FIELD FieldData 2\ntwo 2 4 float" : "FIELD FieldData 2\ntwo 2 1 float");
        vtk_numbers(f, 'f', 4, values, grid ? 8 : 2);
        vtk_line(f, grid ? "region 1 4 int" : "region 1 1 int");
        vtk_numbers(f, 'i', 4, regions, grid ? 4 : 1);
    }
}

/* The group of an element as its tag; 0: none. */
static long long tag_of(const pbwio_cloud *c, const pbw_index *groups, size_t i)
{
    return groups == NULL || groups[i] == PBW_NONE ? 0 : c->groups[groups[i]].tag;
}

static void check_vtk(const char *version, int binary, int grid, int extras)
{
    static vtk_file f;
    pbwio_options options;
    pbwio_cloud c;
    pbwio_error error;
    memset(&options, 0, sizeof options);
    options.weight = extras ? "mass" : NULL;
    make_vtk(&f, version, binary, grid, extras);
    if (!CHECK(pbwio_read_memory(extras ? "a.vtk" : "a.what", f.bytes, f.size, &options, &c, &error) == PBWIO_OK)) {
        test_say("version %s, %d, %d, %d: %s", version, binary, grid, extras, error.text);
        return;
    }
    CHECK(c.dim == 3 && c.count == 6 && c.triangle_count == 2 && fabs(area_of(&c) - 5) < 1e-12);
    CHECK(c.tetrahedron_count == (grid ? 2 : 0) && c.segment_count == (grid ? 1 : 0));
    if (!CHECK(strcmp(c.dropped, extras ? "data: TIME, flow, id, two" : "") == 0)) {
        test_say("%s", c.dropped);
    }
    CHECK(tag_of(&c, c.triangle_groups, 0) == (extras ? 7 : 0) && tag_of(&c, c.triangle_groups, 1) == (extras ? 7
        : 0));
    CHECK(!grid || (tag_of(&c, c.tetrahedron_groups, 0) == (extras ? 7 : 0)
                    && tag_of(&c, c.tetrahedron_groups, 1) == (extras ? 9 : 0)
                    && tag_of(&c, c.segment_groups, 0) == (extras ? 5 : 0)));
    CHECK(!extras || (c.weights != NULL && c.weights[5] > 5.5));
    pbwio_free(&c);
}

#define VTK_HEAD "# vtk DataFile Version 3.0\ntitle\nASCII\n"
#define VTK_POLY VTK_HEAD "DATASET POLYDATA\nPOINTS 4 float\n0 0 0 2 0 0 2 2 0 0 2 0\n"
#define VTK_GRID VTK_HEAD "DATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 2 0 0 2 2 0 0 2 0\n"

static const reading vtks[] = {
    { "strip.vtk",
      VTK_HEAD "DATASET POLYDATA\nPOINTS 4 float\n0 0 0 2 0 0 0 2 0 2 2 0\nTRIANGLE_STRIPS 1 5\n4 0 1 2 3\n",
      NULL, 3, 4, 2, 8, 4, NULL },
    { "pixel.vtk",
      VTK_HEAD "DATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 2 0 0 0 2 0 2 2 0\nCELLS 1 5\n4 0 1 2 3\n"
      "CELL_TYPES 1\n8\n", NULL, 3, 4, 2, 8, 4, NULL },
    { "quadratic.vtk", VTK_HEAD "DATASET UNSTRUCTURED_GRID\nPOINTS 6 float\n0 0 0 2 0 0 0 2 0 1 0 0 1 1 0 0 1 0\n"
      "CELLS 1 7\n6 0 1 2 3 4 5\nCELL_TYPES 1\n22\n", NULL, 3, 3, 1, 4, 2, "second-order" },
    { "parts.vtk", VTK_POLY "VERTICES 1 2\n1 0\nLINES 1 3\n2 0 1\nPOLYGONS 2 8\n3 0 1 2 3 0 2 3\n", NULL, 3, 4, 2, 8,
      4, NULL },
    { "lower.vtk", "# vtk datafile version 2.0\n\nascii\ndataset polydata\npoints 4 Float\n0 0 0 2 0 0 2 2 0 0 2 0\n"
      "polygons 1 5\n4 0 1 2 3\n", NULL, 3, 4, 2, 8, 4, NULL },
    { "windows.vtk",
      "# vtk DataFile Version 3.0\r\nt\r\nASCII\r\nDATASET POLYDATA\r\nPOINTS 3 float\r\n0 0 0\r\n2 0 0\r\n"
      "0 2 0\r\nPOLYGONS 1 4\r\n3 0 1 2\r\n", NULL, 3, 3, 1, 4, 2, NULL },
    { "points_only.vtk", VTK_POLY, NULL, 3, 4, 0, 8, 0, NULL },
    { "hexahedron.vtk", VTK_GRID "CELLS 1 9\n8 0 1 2 3 0 1 2 3\nCELL_TYPES 1\n12\n", NULL, 3, 4, 0, 8, 0,
      "hexahedra" },
    { "image.vtk", VTK_HEAD "DATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n", NULL, 0, 0, 0, 0, 0,
      "image.vtk:4: data sets UNSTRUCTURED_GRID and POLYDATA are read, \"STRUCTURED_POINTS\" is not" },
    { "rectilinear.vtk", VTK_HEAD "DATASET RECTILINEAR_GRID\n", NULL, 0, 0, 0, 0, 0, "\"RECTILINEAR_GRID\" is not" },
    { "what.vtk", VTK_POLY "WHAT 1\n", NULL, 0, 0, 0, 0, 0, "what.vtk:7: \"WHAT\" is no section of .vtk" },
    { "type.vtk", VTK_HEAD "DATASET POLYDATA\nPOINTS 1 real\n0 0 0\n", NULL, 0, 0, 0, 0, 0,
      "type.vtk:5: \"real\" is not a type" },
    { "corner.vtk", VTK_POLY "POLYGONS 1 4\n3 0 1 9\n", NULL, 0, 0, 0, 0, 0, "a face has point 9, there are 4" },
    { "short.vtk", VTK_POLY "POLYGONS 2 8\n3 0 1 2\n", NULL, 0, 0, 0, 0, 0, "the file ends too early" },
    { "third.vtk", "# vtk DataFile Version 3.0\nt\nHEX\n", NULL, 0, 0, 0, 0, 0,
      "the third line is not \"ASCII\" or \"BINARY\"" },
    { "table.vtk", "1 2 3\n", NULL, 0, 0, 0, 0, 0, "the first line is not \"# vtk DataFile Version\"" }
};

static void test_vtk(void)
{
    static const char *const versions[] = { "1.0", "2.0", "3.0", "4.2", "5.0", "5.1" };
    int i, k;
    for (i = 0; i < 6; i++) {
        for (k = 0; k < 8; k++) {
            check_vtk(versions[i], k & 1, k >> 1 & 1, k >> 2);
        }
    }
    CHECK_ALL(vtks);
}

int main(int argc, char **argv)
{
    static const struct { const char *name; void (*run)(void); } tests[] = {
        { "polygons", test_polygons }, { "spellings of .stl", test_stl }, { "what is not read", test_refusals },
        { "data that is not kept", test_unkept },
        { ".gz is written", test_gzip }, { "columns of tables", test_tables },
        { "lists of .json", test_json },
        { "every .vtk", test_vtk }
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
