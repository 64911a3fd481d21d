/* fuzz_solid.c: small soups of triangles decoded from bytes, flat, crossing, repeated, not finite: pbw_solid returns
   a sound mesh, or a status that fits; faults of its boundary are counted.
       make fuzz            libFuzzer where clang is installed, else random bytes
       make fuzz-solid      COUNT soups of random bytes, under the sanitizers */
#define PBW_IMPLEMENTATION
#include "../pbw.h"
#define PBW_SURFACE_IMPLEMENTATION
#include "../examples/lib/pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "../examples/lib/pbw_improve.h"
#define PBW_MESH3_IMPLEMENTATION
#include "../examples/lib/pbw_mesh3.h"
#include "small.h"
#include "fuzz.h"

enum { SOUP_POINTS = 40, SOUP_TRIANGLES = 80 };

typedef struct soup {
    double points[SOUP_POINTS * 3];
    pbw_index triangles[SOUP_TRIANGLES * 3], patches[SOUP_TRIANGLES];
    size_t count, triangle_count;
    pbw_solid_input in;
    pbw_solid_options how;
} soup;

/* The boundary of a box, or an octahedron, of points that are already there. */
static void soup_close(soup *s, size_t first, unsigned which)
{
    static const pbw_index box[12][3] = { { 0, 2, 3 }, { 0, 3, 1 }, { 4, 5, 7 }, { 4, 7, 6 }, { 0, 1, 5 },
                                          { 0, 5, 4 }, { 2, 6, 7 }, { 2, 7, 3 }, { 0, 4, 6 }, { 0, 6, 2 },
                                          { 1, 3, 7 }, { 1, 7, 5 } };
    static const pbw_index peaks[8][3] = { { 0, 2, 4 }, { 2, 1, 4 }, { 1, 3, 4 }, { 3, 0, 4 }, { 2, 0, 5 },
                                           { 1, 2, 5 }, { 3, 1, 5 }, { 0, 3, 5 } };
    size_t i, k;
    for (i = 0; i < (which ? 8u : 12u) && s->triangle_count < SOUP_TRIANGLES; i++, s->triangle_count++) {
        for (k = 0; k < 3; k++) {
            s->triangles[3 * s->triangle_count + k] = (pbw_index)first + (which ? peaks[i][k] : box[i][k]);
        }
    }
}

static double soup_number(unsigned kind, small_bytes *bytes)
{
    const double x = (double)small_take(bytes);
    const unsigned rare = small_take(bytes);
    return kind == 0 ? floor(x / 43) : kind == 1 ? x / 16 : kind == 2 ? (x * 256 + rare) * 0.1
         : kind == 3 && rare == 0 ? (x < 100 ? NAN : x < 200 ? HUGE_VAL : 1e300)
         : kind == 4 ? ldexp(x, (int)(rare % 40) - 20) : x + ldexp(rare, -50);
}

static void soup_decode(soup *s, const unsigned char *data, size_t size)
{
    small_bytes bytes;
    unsigned shape, kind;
    size_t i;
    int k;
    bytes.at = data;
    bytes.left = size;
    memset(s, 0, sizeof *s);
    shape = small_take(&bytes);
    kind = small_take(&bytes) % 6;
    s->count = 3 + small_take(&bytes) % (SOUP_POINTS - 2);
    for (i = 0; i < 3 * s->count; i++) {
        s->points[i] = soup_number(kind, &bytes);
    }
    for (i = 0; shape % 4 != 0 && i + 8 <= s->count && i < (shape % 4) * 8; i += 8) {    /* boxes, bent */
        const double low[3] = { (double)(i % 3), (double)(i / 16), 0 }, side = shape & 64 ? 0.1 : 1 + (double)i;
        for (k = 0; k < 24; k++) {
            double *x = s->points + 3 * i + k;
            const double at = low[k % 3] + ((k / 3) >> (k % 3) & 1 ? side : 0);
            *x = shape & 128 ? at + 1e-3 * fmod(*x, 100) : at;
        }
        soup_close(s, i, 0);
    }
    if (shape % 4 == 0 && s->count >= 6) {
        soup_close(s, 0, 1);
    }
    for (i = shape & 16 ? small_take(&bytes) % 50 : 0; i > 0 && s->triangle_count < SOUP_TRIANGLES; i--) {
        for (k = 0; k < 3; k++) {
            s->triangles[3 * s->triangle_count + (size_t)k] = (pbw_index)(small_take(&bytes) % s->count);
        }
        s->triangle_count++;
    }
    if (shape & 32 && s->triangle_count > 3) {       /* a hole */
        s->triangle_count -= 1 + small_take(&bytes) % 3;
    }
    for (i = 0; i < s->triangle_count; i++) {
        s->patches[i] = small_take(&bytes) % 3;
    }
    s->in.points = s->points;
    s->in.point_count = s->count;
    s->in.triangles = s->triangles;
    s->in.triangle_count = s->triangle_count;
    s->in.patches = small_take(&bytes) % 4 == 0 ? s->patches : NULL;
    s->how.nested = small_take(&bytes) % 3 == 0;
    s->how.curvature = small_take(&bytes) % 4 == 0 ? 0.5 : 0;
    s->how.rounds = 1 + (int)(small_take(&bytes) % 6);
    s->how.improve.passes = 1 + (int)(small_take(&bytes) % 4);
}

/* Positive tetrahedra without orphans whose facets fit their neighbours; NULL, or what is wrong. */
static const char *soup_judge(const pbw_tets *t, const pbw_solid_boundary *b, const pbw_solid_report *r)
{
    unsigned char *used = (unsigned char *)calloc(t->point_count + 1, 1);
    size_t i, k, orphans = t->point_count;
    const char *fault = used == NULL ? "no memory" : t->tet_count == 0 ? "no tetrahedra" : NULL;
    for (i = 0; fault == NULL && i < t->tet_count; i++) {
        const pbw_index *c = t->corners + 4 * i;
        for (k = 0; k < 4 && fault == NULL; k++) {
            const pbw_index next = t->neighbors[4 * i + k];
            fault = c[k] >= t->point_count ? "a corner out of range"
                  : next != PBW_NONE && next >= t->tet_count ? "a neighbour out of range" : NULL;
            if (fault == NULL) {
                orphans -= !used[c[k]];
                used[c[k]] = 1;
            }
        }
        fault = fault != NULL || pbw_orient3(t->points + 3 * (size_t)c[0], t->points + 3 * (size_t)c[1],
                                             t->points + 3 * (size_t)c[2], t->points + 3 * (size_t)c[3]) > 0
              ? fault : "a tetrahedron that is not positive";
    }
    free(used);
    return fault != NULL ? fault : orphans > 0 ? "a point that is corner of nothing"
         : b->facet_count != r->facets || b->hole_count != r->holes ? "the report differs from the boundary"
         : !(r->distance >= 0) ? "no distance" : NULL;
}

static const char *fuzz(const unsigned char *data, size_t size, int print)
{
    static soup s;
    pbw_options options;
    pbw_solid_boundary boundary;
    pbw_solid_report report;
    pbw_tets mesh;
    pbw_status status;
    const char *fault = NULL;
    double low[3] = { HUGE_VAL, HUGE_VAL, HUGE_VAL }, high[3] = { -HUGE_VAL, -HUGE_VAL, -HUGE_VAL };
    size_t i;
    soup_decode(&s, data, size);
    for (i = 0; i < 9 * s.triangle_count; i++) {
        const double x = s.points[3 * (size_t)s.triangles[i / 3] + i % 3];
        low[i % 3] = fmin(low[i % 3], x);
        high[i % 3] = fmax(high[i % 3], x);
    }
    s.how.size = pbwsf__distance(low, high) / 6;     /* coarse: some hundred tetrahedra */
    s.how.size = s.how.size < 1e100 ? s.how.size : 0;
    s.how.least_size = s.how.size / 2;
    memset(&options, 0, sizeof options);
    options.threads = 1;
    if (print) {
        for (i = 0; i < s.count; i++) {
            printf("v %.17g %.17g %.17g\n", s.points[3 * i], s.points[3 * i + 1], s.points[3 * i + 2]);
        }
        for (i = 0; i < s.triangle_count; i++) {
            printf("f %u %u %u\n", s.triangles[3 * i] + 1, s.triangles[3 * i + 1] + 1, s.triangles[3 * i + 2] + 1);
        }
        printf("# size %.17g, nested %d, curvature %g, rounds %d\n", s.how.size, s.how.nested, s.how.curvature,
               s.how.rounds);
    }
    status = pbw_solid(&s.in, &s.how, &options, &mesh, &boundary, &report);
    if (status == PBW_OK) {
        fault = soup_judge(&mesh, &boundary, &report);
    } else if (status != PBW_DEGENERATE && status != PBW_ERROR_NOT_FINITE) {
        fault = pbw_status_string(status);
    }
    pbw_solid_boundary_free(&boundary);
    pbw_tets_free(&mesh);
    return fault;
}
