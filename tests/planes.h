/* planes.h: what tests of plane domains share: an exact check of a pbw_plane, a slow constrained triangulation by
   flips, small inputs from bytes, and a number for a set of triangles.  Include pbw_mesh2.h before. */
#ifndef PLANES_H
#define PLANES_H

#include "small.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__GNUC__)
#define PLANES_UNUSED __attribute__((unused))
#else
#define PLANES_UNUSED
#endif

static const double *planes_at(const double *p, size_t i) { return p + 2 * i; }

PLANES_UNUSED static int planes_same(const double *a, const double *b)
{
    return a[0] <= b[0] && a[0] >= b[0] && a[1] <= b[1] && a[1] >= b[1];
}

PLANES_UNUSED static int planes_before(const double *a, const double *b)
{
    return a[0] < b[0] || (a[0] <= b[0] && a[1] < b[1]);
}

/* c strictly between a and b, on one line with them */
PLANES_UNUSED static int planes_between(const double *a, const double *c, const double *b)
{
    return pbw_orient2(a, b, c) == 0 && planes_before(a, c) == planes_before(c, b) && !planes_same(a, c)
        && !planes_same(b, c);
}

PLANES_UNUSED static int planes_cross(const double *a, const double *b, const double *c, const double *d)
{
    return pbw_orient2(a, b, c) * pbw_orient2(a, b, d) < 0 && pbw_orient2(c, d, a) * pbw_orient2(c, d, b) < 0;
}

/* Twice the area. */
PLANES_UNUSED static long double planes_area(const pbw_plane *plane)
{
    long double sum = 0;
    size_t i;
    for (i = 0; i < plane->triangle_count; i++) {
        const double *a = planes_at(plane->points, plane->triangles[3 * i]);
        const double *b = planes_at(plane->points, plane->triangles[3 * i + 1]);
        const double *c = planes_at(plane->points, plane->triangles[3 * i + 2]);
        sum += ((long double)b[0] - a[0]) * ((long double)c[1] - a[1])
             - ((long double)b[1] - a[1]) * ((long double)c[0] - a[0]);
    }
    return sum;
}

/* Triangles: corners, orientation, neighbours, constraints on both sides, free edges locally regular. */
static const char *planes_triangles_fault(const pbw_plane *plane)
{
    size_t i, k, j;
    for (i = 0; i < plane->triangle_count; i++) {
        const pbw_index *v = plane->triangles + 3 * i;
        for (k = 0; k < 3; k++) {
            if (v[k] >= plane->point_count) {
                return "a corner that is not there";
            }
        }
        if (pbw_orient2(planes_at(plane->points, v[0]), planes_at(plane->points, v[1]),
                        planes_at(plane->points, v[2])) <= 0) {
            return "a triangle that is not counter-clockwise";
        }
    }
    for (i = 0; i < plane->triangle_count; i++) {
        const pbw_index *v = plane->triangles + 3 * i;
        for (k = 0; k < 3; k++) {
            const pbw_index n = plane->neighbors[3 * i + k], e = plane->constraints[3 * i + k];
            const pbw_index a = v[(k + 1) % 3], b = v[(k + 2) % 3];
            if (e != PBW_NONE && (e >= plane->edge_count || plane->edges[2 * e] + plane->edges[2 * e + 1] != a + b
                || (plane->edges[2 * e] != a && plane->edges[2 * e] != b))) {
                return "an edge with other ends";
            }
            if (n == PBW_NONE) {
                if (e == PBW_NONE) {
                    return "a border that is no constraint";
                }
                continue;
            }
            for (j = 0; j < 3 && plane->neighbors[3 * (size_t)n + j] != i; j++) {
            }
            if (j == 3 || plane->triangles[3 * (size_t)n + (j + 1) % 3] != b
                || plane->triangles[3 * (size_t)n + (j + 2) % 3] != a) {
                return "neighbours that do not agree";
            }
            if (plane->constraints[3 * (size_t)n + j] != e) {
                return "a constraint on one side only";
            }
            if (e == PBW_NONE && (plane->regions[n] != plane->regions[i]
                || pbw_conflict2(planes_at(plane->points, v[0]), planes_at(plane->points, v[1]),
                                 planes_at(plane->points, v[2]),
                                 planes_at(plane->points, plane->triangles[3 * (size_t)n + j]), NULL))) {
                return plane->regions[n] != plane->regions[i] ? "two regions without a segment between"
                     : "a free edge that is not locally regular";
            }
        }
    }
    return NULL;
}

typedef struct planes_link { pbw_index id, a, b; int used; } planes_link;

static int planes_compare(const void *x, const void *y)
{
    const planes_link *a = (const planes_link *)x, *b = (const planes_link *)y;
    return a->id != b->id ? (a->id < b->id ? -1 : 1) : 0;
}

/* The places that edges lead to from a place: those of edges that are used, and b if there. */
static int planes_reaches(const pbw_plane *plane, planes_link *link, size_t count, const double *a, const double *b)
{
    int more = 1, found = planes_same(a, b);
    size_t i, k, e;
    while (more) {
        more = 0;
        for (i = 0; i < count; i++) {
            for (k = 0; k <= count && !link[i].used; k++) {
                for (e = 0; e < 4; e++) {
                    const double *mine = planes_at(plane->points, e % 2 == 0 ? link[i].a : link[i].b);
                    const double *other = k == count ? a : !link[k].used ? NULL
                                        : planes_at(plane->points, e / 2 == 0 ? link[k].a : link[k].b);
                    link[i].used |= other != NULL && planes_same(mine, other);
                }
                more |= link[i].used;
            }
            found |= link[i].used && (planes_same(planes_at(plane->points, link[i].a), b)
                                      || planes_same(planes_at(plane->points, link[i].b), b));
        }
    }
    return found;
}

/* Every segment is a chain of edges from end to end; exact: each vertex on it lies on its line. */
static const char *planes_segments_fault(const pbw_plane *plane, const pbw_index *segments, size_t count, int exact)
{
    const size_t total = plane->edge_count > 0 ? plane->edge_first[plane->edge_count] : 0;
    planes_link *link = (planes_link *)malloc((total + 1) * sizeof *link);
    const char *fault = NULL;
    size_t i, k, n = 0, at = 0, end;
    for (i = 0; i < plane->edge_count; i++) {
        for (k = plane->edge_first[i]; k < plane->edge_first[i + 1]; k++, n++) {
            link[n].id = plane->edge_segments[k];
            link[n].a = plane->edges[2 * i];
            link[n].b = plane->edges[2 * i + 1];
            link[n].used = 0;
        }
    }
    qsort(link, n, sizeof *link, planes_compare);
    for (i = 0; i < count && fault == NULL; i++, at = end) {
        const double *a = planes_at(plane->points, segments[2 * i]);
        const double *b = planes_at(plane->points, segments[2 * i + 1]);
        const double *here = a;
        for (end = at; end < n && link[end].id == i; end++) {
            fault = exact && (pbw_orient2(a, b, planes_at(plane->points, link[end].a)) != 0
                              || pbw_orient2(a, b, planes_at(plane->points, link[end].b)) != 0)
                  ? "an edge beside its segment" : fault;
        }
        if (!exact) {
            fault = planes_reaches(plane, link + at, end - at, a, b) ? fault : "a segment that is not there";
            continue;
        }
        for (k = at; k < end && !planes_same(here, b); ) {
            if (!link[k].used && (planes_same(planes_at(plane->points, link[k].a), here)
                                  || planes_same(planes_at(plane->points, link[k].b), here))) {
                link[k].used = 1;
                here = planes_at(plane->points, planes_same(planes_at(plane->points, link[k].a), here) ? link[k].b
                                 : link[k].a);
                k = at;
            } else {
                k++;
            }
        }
        fault = planes_same(here, b) ? fault : "a segment that is not there";
        for (k = at; k < end; k++) {
            fault = link[k].used ? fault : "an edge that is no part of its segment";
        }
    }
    free(link);
    return fault;
}

PLANES_UNUSED static const char *planes_fault(const pbw_plane *plane, const pbw_index *segments, size_t count,
                                              int exact)
{
    const char *fault = planes_triangles_fault(plane);
    return fault != NULL || segments == NULL ? fault : planes_segments_fault(plane, segments, count, exact);
}

/* A number for the set of triangles, by the places of their corners. */
PLANES_UNUSED static uint64_t planes_hash(const pbw_plane *plane)
{
    uint64_t sum = plane->triangle_count;
    size_t i, k, j;
    for (i = 0; i < plane->triangle_count; i++) {
        uint64_t corners = 0;
        for (k = 0; k < 3; k++) {
            uint64_t h = 0;
            for (j = 0; j < 2; j++) {
                const double x = planes_at(plane->points, plane->triangles[3 * i + k])[j] + 0.0;
                uint64_t bits;
                memcpy(&bits, &x, sizeof bits);
                h = (h ^ bits) * 0x9e3779b97f4a7c15u;
                h ^= h >> 29;
            }
            corners += h * 0xbf58476d1ce4e5b9u;
        }
        corners ^= corners >> 31;
        sum += corners * 0x94d049bb133111ebu;
    }
    return sum;
}

static uint64_t planes_mix(uint64_t sum, const void *bytes, size_t size)
{
    size_t i;
    for (i = 0; i < size; i++) {                     /* FNV-1a */
        sum = (sum ^ ((const unsigned char *)bytes)[i]) * 0x100000001b3u;
    }
    return sum;
}

/* A number for all bytes of a result. */
PLANES_UNUSED static uint64_t planes_digest(const pbw_plane *p)
{
    const size_t corners = 3 * p->triangle_count * sizeof(pbw_index);
    const size_t parts = p->edge_count > 0 ? p->edge_count + 1 : 0;
    uint64_t sum = planes_mix(0xcbf29ce484222325u, p->points, 2 * p->point_count * sizeof(double));
    sum = planes_mix(planes_mix(sum, p->triangles, corners), p->neighbors, corners);
    sum = planes_mix(planes_mix(sum, p->constraints, corners), p->regions, corners / 3);
    sum = planes_mix(planes_mix(sum, p->edges, 2 * p->edge_count * sizeof(pbw_index)), p->edge_first,
                     parts * sizeof(size_t));
    sum = planes_mix(sum, p->edge_segments, (parts > 0 ? p->edge_first[p->edge_count] : 0) * sizeof(pbw_index));
    sum = planes_mix(sum, p->region_windings, p->region_count * sizeof(int));
    sum = planes_mix(sum, p->region_seeds, p->region_count * sizeof(pbw_index));
    return planes_mix(sum, p->crossings, 2 * p->crossing_count * sizeof(pbw_index));
}

/* ---- the constrained triangulation of a few points, slowly: any with the segments in it, then flips */

enum { PLANES_MOST = 32 };

typedef struct planes_slow {
    int n;
    const double *p;
    unsigned char edge[PLANES_MOST][PLANES_MOST];    /* 1: free, 2: of a segment */
} planes_slow;

/* Returns whether i, j and k, counter-clockwise, have all three edges and nothing inside. */
static int planes_is_triangle(const planes_slow *s, int i, int j, int k)
{
    const double *a = planes_at(s->p, (size_t)i), *b = planes_at(s->p, (size_t)j), *c = planes_at(s->p, (size_t)k);
    int m;
    if (!s->edge[i][j] || !s->edge[j][k] || !s->edge[k][i] || pbw_orient2(a, b, c) <= 0) {
        return 0;
    }
    for (m = 0; m < s->n; m++) {
        const double *d = planes_at(s->p, (size_t)m);
        if (m != i && m != j && m != k && pbw_orient2(a, b, d) >= 0 && pbw_orient2(b, c, d) >= 0
            && pbw_orient2(c, a, d) >= 0) {
            return 0;
        }
    }
    return 1;
}

static void planes_slow_add(planes_slow *s, int i, int j, unsigned char kind)
{
    const double *a = planes_at(s->p, (size_t)i), *b = planes_at(s->p, (size_t)j);
    int k, m;
    if (i == j || s->edge[i][j] >= kind) {
        return;
    }
    for (k = 0; k < s->n; k++) {
        if (planes_between(a, planes_at(s->p, (size_t)k), b)) {
            if (kind == 2) {
                planes_slow_add(s, i, k, 2);
                planes_slow_add(s, k, j, 2);
            }
            return;
        }
    }
    for (k = 0; k < s->n; k++) {
        for (m = 0; m < k; m++) {
            if (s->edge[k][m] && planes_cross(a, b, planes_at(s->p, (size_t)k), planes_at(s->p, (size_t)m))) {
                return;
            }
        }
    }
    s->edge[i][j] = s->edge[j][i] = kind;
}

/* Points are all different; segments do not cross.  Returns the number of triangles. */
PLANES_UNUSED static int planes_slow_make(planes_slow *s, const pbw_index *segments, size_t count)
{
    int i, j, k, m, flipped, triangles = 0;
    size_t q;
    memset(s->edge, 0, sizeof s->edge);
    for (q = 0; q < count; q++) {
        planes_slow_add(s, (int)segments[2 * q], (int)segments[2 * q + 1], 2);
    }
    for (i = 0; i < s->n; i++) {
        for (j = 0; j < i; j++) {
            planes_slow_add(s, i, j, 1);
        }
    }
    do {
        flipped = 0;
        for (i = 0; i < s->n; i++) {
            for (j = 0; j < s->n; j++) {
                for (k = 0; s->edge[i][j] == 1 && k < s->n && !planes_is_triangle(s, i, j, k); k++) {
                }
                for (m = 0; s->edge[i][j] == 1 && k < s->n && m < s->n && !planes_is_triangle(s, j, i, m); m++) {
                }
                if (s->edge[i][j] == 1 && k < s->n && m < s->n
                    && pbw_conflict2(planes_at(s->p, (size_t)i), planes_at(s->p, (size_t)j),
                                     planes_at(s->p, (size_t)k), planes_at(s->p, (size_t)m), NULL)) {
                    s->edge[i][j] = s->edge[j][i] = 0;
                    s->edge[k][m] = s->edge[m][k] = 1;
                    flipped = 1;
                }
            }
        }
    } while (flipped);
    for (i = 0; i < s->n; i++) {
        for (j = i + 1; j < s->n; j++) {
            for (k = i + 1; k < s->n; k++) {
                triangles += planes_is_triangle(s, i, j, k);
            }
        }
    }
    return triangles;
}

/* ---- small inputs from bytes, and the verdict on them */

enum { PLANES_SEGMENTS = 16 };

typedef struct planes_small {
    small_input in;
    pbw_index segments[2 * PLANES_SEGMENTS];
    size_t count;
    char what[160];                                  /* the text of a failed call */
} planes_small;

static const char *planes_keep(planes_small *s, const pbw_plane *plane)
{
    memcpy(s->what, plane->what, sizeof s->what);
    return s->what;
}

PLANES_UNUSED static void planes_small_decode(planes_small *s, const unsigned char *data, size_t size)
{
    unsigned char head[512];
    size_t length = size < sizeof head ? size : sizeof head, i;
    memset(s, 0, sizeof *s);
    if (length < 4) {
        return;
    }
    memcpy(head, data, length);
    head[0] &= 0xfc;                                 /* in the plane, without weights */
    small_decode(&s->in, head, length);
    if (s->in.count == 0) {
        return;
    }
    s->count = data[length - 1] % (PLANES_SEGMENTS + 1);
    for (i = 0; i < 2 * s->count; i++) {
        s->segments[i] = (pbw_index)(data[(length - 2 + length - i) % length] % s->in.count);
    }
}

PLANES_UNUSED static void planes_small_print(const planes_small *s)
{
    size_t i;
    small_print(&s->in);
    printf("    pbw_index segments[] = { ");
    for (i = 0; i < s->count; i++) {
        printf("%u,%u%s", (unsigned)s->segments[2 * i], (unsigned)s->segments[2 * i + 1],
               i + 1 < s->count ? ",  " : "");
    }
    printf(" };\n");
}

/* Returns whether two segments cross where no point is. */
static int planes_small_cross(const planes_small *s, size_t i, size_t j)
{
    const double *p = s->in.points, *a = p + 2 * s->segments[2 * i], *b = p + 2 * s->segments[2 * i + 1];
    const double *c = p + 2 * s->segments[2 * j], *d = p + 2 * s->segments[2 * j + 1];
    int k, crosses = planes_cross(a, b, c, d);
    for (k = 0; k < s->in.count && crosses; k++) {
        crosses = !planes_between(a, p + 2 * k, b) || !planes_between(c, p + 2 * k, d);
    }
    return crosses;
}

/* Leaves out, in order, segments that cross an earlier one; or counts the pairs. */
static size_t planes_small_pairs(planes_small *s, int remove)
{
    size_t i, j, kept = 0, pairs = 0;
    for (i = 0; i < s->count; i++) {
        int crosses = 0;
        for (j = 0; j < (remove ? kept : i); j++) {
            crosses += planes_small_cross(s, i, j);
        }
        pairs += (size_t)crosses;
        if (remove && !crosses) {
            s->segments[2 * kept] = s->segments[2 * i];
            s->segments[2 * kept + 1] = s->segments[2 * i + 1];
            kept++;
        }
    }
    s->count = remove ? kept : s->count;
    return pairs;
}

/* Compares with the slow triangulation. */
static const char *planes_small_compare(const planes_small *s, const pbw_plane *plane)
{
    planes_slow slow;
    double places[2 * PLANES_MOST];
    pbw_index place[PLANES_MOST], segments[2 * PLANES_SEGMENTS];
    int i, j, triangles;
    size_t k;
    slow.n = 0;
    slow.p = places;
    for (i = 0; i < s->in.count; i++) {
        for (j = 0; j < slow.n && !planes_same(places + 2 * j, s->in.points + 2 * i); j++) {
        }
        place[i] = (pbw_index)j;
        memcpy(places + 2 * j, s->in.points + 2 * i, 2 * sizeof *places);
        slow.n += j == slow.n;
    }
    for (k = 0; k < 2 * s->count; k++) {
        segments[k] = place[s->segments[k]];
    }
    triangles = planes_slow_make(&slow, segments, s->count);
    for (k = 0; k < plane->triangle_count; k++) {
        const pbw_index *v = plane->triangles + 3 * k;
        if (!planes_is_triangle(&slow, (int)place[v[0]], (int)place[v[1]], (int)place[v[2]])) {
            return "a triangle that the slow way has not";
        }
    }
    return (size_t)triangles == plane->triangle_count ? NULL : "another number of triangles than the slow way";
}

/* Repeats it with the points in another order and the segments reversed, and compares. */
static const char *planes_small_turned(planes_small *s, const pbw_plane_options *options, uint64_t hash)
{
    planes_small t = *s;
    pbw_plane_input input;
    pbw_plane plane;
    const size_t n = (size_t)s->in.count;
    const char *fault;
    size_t i;
    for (i = 0; i < n; i++) {
        memcpy(t.in.points + 2 * (n - 1 - i), s->in.points + 2 * i, 2 * sizeof(double));
    }
    for (i = 0; i < 2 * s->count; i++) {
        t.segments[2 * s->count - 1 - i] = (pbw_index)(n - 1 - s->segments[i]);
    }
    memset(&input, 0, sizeof input);
    input.points = t.in.points;
    input.point_count = n;
    input.segments = t.segments;
    input.segment_count = t.count;
    fault = pbw_plane_make(&input, options, &plane) != PBW_OK ? planes_keep(s, &plane)
          : planes_hash(&plane) != hash ? "other triangles for another order" : NULL;
    pbw_plane_free(&plane);
    return fault;
}

/* The least difference of coordinates, or size of one, as part of the largest: where it is tiny, rounded crossings
   need not settle, and refinement needs very many points. */
static double planes_small_spread(const planes_small *s)
{
    double least = 1e300, most = 0;
    int i, j;
    for (i = 0; i < 2 * s->in.count; i++) {
        const double x = fabs(s->in.points[i]);
        most = x > most ? x : most;
        for (j = 0; j <= i; j++) {
            const double apart = j == i ? x : fabs(s->in.points[i] - s->in.points[j]);
            least = apart > 0 && apart < least ? apart : least;
        }
    }
    return least < 1e-300 ? 0 : least / most;
}

static const char *planes_small_crossings(planes_small *s, const pbw_plane_input *input, pbw_plane_options *options)
{
    const size_t pairs = planes_small_pairs(s, 0);
    pbw_plane plane;
    pbw_status status = pbw_plane_make(input, options, &plane);
    const char *fault = status != PBW_ERROR_ARGUMENT || plane.crossing_count != pairs ? "other crossings" : NULL;
    size_t i;
    for (i = 0; i < plane.crossing_count && fault == NULL; i++) {
        const pbw_index *c = plane.crossings + 2 * i;
        fault = c[0] < c[1] && planes_small_cross(s, c[0], c[1]) ? NULL : "no crossing";
    }
    pbw_plane_free(&plane);
    options->flags |= PBW_PLANE_SPLIT_CROSSINGS;
    status = pbw_plane_make(input, options, &plane);
    if (fault == NULL && status != PBW_OK
        && (strstr(plane.what, "do not settle") == NULL || planes_small_spread(s) > 1e-13)) {
        fault = planes_keep(s, &plane);
    }
    fault = fault == NULL && status == PBW_OK ? planes_fault(&plane, s->segments, s->count, 0) : fault;
    pbw_plane_free(&plane);
    options->flags &= ~PBW_PLANE_SPLIT_CROSSINGS;
    planes_small_pairs(s, 1);
    return fault;
}

/* Refines and checks: segments and hull are kept; angles are small only at small angles of the input, or if a limit
   was reached. */
static const char *planes_small_refine(planes_small *s, const pbw_plane_input *input, pbw_plane_options *options)
{
    pbw_plane plane, before;
    const char *fault = NULL;
    double low = HUGE_VAL, high = -HUGE_VAL;
    long double area, most;
    pbw_status status;
    int i;
    for (i = 0; i < 2 * s->in.count; i++) {
        low = fmin(low, s->in.points[i]);
        high = fmax(high, s->in.points[i]);
    }
    most = 1e-12L * (long double)fmax(fabs(low), fabs(high)) * ((long double)high - low);
    (void)pbw_plane_make(input, options, &before);
    area = planes_area(&before);
    pbw_plane_free(&before);
    options->flags |= PBW_PLANE_REFINE;
    options->steiner_limit = planes_small_spread(s) > 0.05 ? 20000 : 50;
    status = pbw_plane_make(input, options, &plane);
    if (status == PBW_OK) {
        fault = planes_fault(&plane, plane.report.steiner_count < 200 ? s->segments : NULL, s->count, 0);
        if (fault == NULL && fabsl(planes_area(&plane) - area) > most) {
            fault = "refinement changes the area";
        }
        if (fault == NULL && plane.report.limited && planes_small_spread(s) > 0.05) {
            fault = "refinement does not end";
        }
    } else if (strstr(plane.what, "scale") == NULL) {
        fault = planes_keep(s, &plane);
    }
    pbw_plane_free(&plane);
    options->flags &= ~PBW_PLANE_REFINE;
    return fault;
}

/* NULL, or what is wrong with the answers. */
PLANES_UNUSED static const char *planes_small_judge(planes_small *s)
{
    pbw_options build;
    pbw_plane_options options;
    pbw_plane_input input;
    pbw_plane plane;
    pbw_status status;
    const char *fault = NULL;
    memset(&build, 0, sizeof build);
    memset(&options, 0, sizeof options);
    memset(&input, 0, sizeof input);
    build.threads = 1;
    options.build = &build;
    input.points = s->in.points;
    input.point_count = (size_t)s->in.count;
    input.segments = s->segments;
    input.segment_count = s->count;
    if (planes_small_pairs(s, 0) > 0) {
        fault = planes_small_crossings(s, &input, &options);
        input.segment_count = s->count;
    }
    status = pbw_plane_make(&input, &options, &plane);
    if (fault == NULL && status == PBW_OK) {
        fault = planes_fault(&plane, s->segments, s->count, 1);
        fault = fault == NULL ? planes_small_compare(s, &plane) : fault;
        fault = fault == NULL ? planes_small_turned(s, &options, planes_hash(&plane)) : fault;
        fault = fault == NULL ? planes_small_refine(s, &input, &options) : fault;
    } else if (fault == NULL && status != PBW_DEGENERATE) {
        fault = planes_keep(s, &plane);
    }
    pbw_plane_free(&plane);
    return fault;
}

#endif
