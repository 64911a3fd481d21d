/* wraps.h: whether a wrap is what pbw_wrap.h promises, by exact predicates and brute force; small soups to wrap. */
#ifndef WRAPS_H
#define WRAPS_H

#include "pbw_wrap.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(__GNUC__)
#define WRAPS_UNUSED __attribute__((unused))
#else
#define WRAPS_UNUSED
#endif

/* ---- two triangles, or what is left of them ---- */

/* Whether the closed segment p q meets the closed triangle c in the plane without axis `drop`; all are coplanar, and
   the triangle has area there. */
static int wraps_meets_flat(const double *p, const double *q, const double *const c[3], int drop)
{
    const int u = (drop + 1) % 3, v = (drop + 2) % 3;
    double a[5][2];
    int i, side, sign[2][3], turn;
    for (i = 0; i < 5; i++) {
        const double *from = i < 3 ? c[i] : i == 3 ? p : q;
        a[i][0] = from[u];
        a[i][1] = from[v];
    }
    turn = pbw_orient2(a[0], a[1], a[2]);
    for (side = 0; side < 2; side++) {                   /* an end inside */
        for (i = 0; i < 3; i++) {
            sign[side][i] = turn * pbw_orient2(a[i], a[(i + 1) % 3], a[3 + side]);
        }
        if (sign[side][0] >= 0 && sign[side][1] >= 0 && sign[side][2] >= 0) {
            return 1;
        }
    }
    for (i = 0; i < 3; i++) {                            /* an edge crossed */
        const int s = pbw_orient2(a[3], a[4], a[i]), t = pbw_orient2(a[3], a[4], a[(i + 1) % 3]);
        if (s * t <= 0 && sign[0][i] * sign[1][i] <= 0 && (s != 0 || t != 0)) {
            return 1;
        }
    }
    return 0;
}

/* The axis without which the triangle has area; -1: it has none. */
static int wraps_axis(const double *const c[3])
{
    int drop, i;
    for (drop = 0; drop < 3; drop++) {
        double a[3][2];
        for (i = 0; i < 3; i++) {
            a[i][0] = c[i][(drop + 1) % 3];
            a[i][1] = c[i][(drop + 2) % 3];
        }
        if (pbw_orient2(a[0], a[1], a[2]) != 0) {
            return drop;
        }
    }
    return -1;
}

/* Whether the closed segment p q, perhaps a point, meets a closed triangle with area. */
static int wraps_segment_meets(const double *p, const double *q, const double *const c[3])
{
    const int above = pbw_orient3(c[0], c[1], c[2], p), below = pbw_orient3(c[0], c[1], c[2], q);
    int i, plus = 0, minus = 0;
    if (above * below > 0) {
        return 0;
    }
    if (above == 0 && below == 0) {
        return wraps_meets_flat(p, q, c, wraps_axis(c));
    }
    for (i = 0; i < 3; i++) {
        const int s = pbw_orient3(p, q, c[i], c[(i + 1) % 3]);
        plus |= s > 0;
        minus |= s < 0;
    }
    return !(plus && minus);
}

/* Whether a facet, which has area, and an element, which may be flat, have a common point. */
static int wraps_meet(const double *const facet[3], const double *const element[3])
{
    int i, k;
    for (k = 0; k < 3; k++) {
        const double *const *a = facet, *const *b = element;
        if (fmax(fmax(a[0][k], a[1][k]), a[2][k]) < fmin(fmin(b[0][k], b[1][k]), b[2][k])
            || fmin(fmin(a[0][k], a[1][k]), a[2][k]) > fmax(fmax(b[0][k], b[1][k]), b[2][k])) {
            return 0;
        }
    }
    for (i = 0; i < 3; i++) {
        if (wraps_segment_meets(element[i], element[(i + 1) % 3], facet)) {
            return 1;
        }
    }
    for (i = 0; i < 3 && wraps_axis(element) >= 0; i++) {
        if (wraps_segment_meets(facet[i], facet[(i + 1) % 3], element)) {
            return 1;
        }
    }
    return 0;
}

/* ---- a wrap and its input ---- */

static void wraps_element(const pbw_wrap_input *in, size_t i, const double *c[3])
{
    const size_t s = i - in->triangle_count;
    size_t k;
    for (k = 0; k < 3; k++) {
        const pbw_index p = i < in->triangle_count ? in->triangles[3 * i + k]
                          : s < in->segment_count ? in->segments[2 * s + (k > 0)]
                                                  : in->singles[s - in->segment_count];
        c[k] = in->points + 3 * (size_t)p;
    }
}

static size_t wraps_elements(const pbw_wrap_input *in)
{
    return in->triangle_count + in->segment_count + in->single_count;
}

/* Whether p is inside, by the parity of a segment to a point outside that touches no edge; -1: on the surface. */
static int wraps_inside(const pbw_wrap_result *w, const double *p)
{
    size_t f, parity, attempt;
    int k;
    for (attempt = 0; attempt < 100; attempt++) {
        double far[3];
        int touches = 0;
        for (k = 0; k < 3; k++) {
            const double at = (double)(pbw_random(attempt, (uint64_t)k) >> 11) * 0x1p-53 - 0.5;
            far[k] = p[k] + (1e3 * (fabs(w->points[0]) + fabs(w->points[1]) + fabs(w->points[2])) + 1e3) * (at + 0.1);
        }
        for (f = parity = 0; f < w->facet_count && !touches; f++) {
            const pbw_index *ids = w->facets + 3 * f;
            const double *a = w->points + 3 * (size_t)ids[0], *b = w->points + 3 * (size_t)ids[1];
            const double *c = w->points + 3 * (size_t)ids[2];
            const int above = pbw_orient3(a, b, c, p), below = pbw_orient3(a, b, c, far);
            int s, t, u;
            if (above == below) {
                touches = above == 0;
                continue;
            }
            s = pbw_orient3(p, far, a, b), t = pbw_orient3(p, far, b, c), u = pbw_orient3(p, far, c, a);
            touches = (s == 0 || t == 0 || u == 0 || above == 0 || below == 0) && !((s > 0 || t > 0 || u > 0)
                                                                                     && (s < 0 || t < 0 || u < 0));
            parity += s == t && t == u;
        }
        if (!touches) {
            return (int)(parity & 1);
        }
    }
    return -1;
}

typedef struct wraps_edge { pbw_index from, to, facet; } wraps_edge;

static int wraps_by_edge(const void *a, const void *b)
{
    const wraps_edge *p = (const wraps_edge *)a, *q = (const wraps_edge *)b;
    return p->from != q->from ? (p->from < q->from ? -1 : 1) : p->to != q->to ? (p->to < q->to ? -1 : 1) : 0;
}

static const wraps_edge *wraps_find(const wraps_edge *edges, size_t count, pbw_index from, pbw_index to)
{
    wraps_edge key;
    key.from = from;
    key.to = to;
    return (const wraps_edge *)bsearch(&key, edges, count, sizeof key, wraps_by_edge);
}

/* Whether facets are a closed, oriented manifold: each edge once in each direction, each vertex with one fan. */
static int wraps_is_manifold(const pbw_wrap_result *w)
{
    const size_t count = 3 * w->facet_count;
    wraps_edge *edges = (wraps_edge *)malloc((count + 1) * sizeof *edges);
    size_t *degree = (size_t *)calloc(w->vertex_count + 1, sizeof *degree), i;
    int good = edges != NULL && degree != NULL && count > 0;
    for (i = 0; good && i < count; i++) {
        edges[i].from = w->facets[i];
        edges[i].to = w->facets[i % 3 == 2 ? i - 2 : i + 1];
        edges[i].facet = (pbw_index)(i / 3);
        good = edges[i].from < w->vertex_count;
        degree[good ? edges[i].from : 0]++;
    }
    if (good) {
        qsort(edges, count, sizeof *edges, wraps_by_edge);
    }
    for (i = 0; good && i < count; i++) {
        good = (i == 0 || wraps_by_edge(edges + i - 1, edges + i) < 0)
            && wraps_find(edges, count, edges[i].to, edges[i].from) != NULL;
    }
    for (i = 0; good && i < count; i++) {                /* a fan from each vertex's first edge has all its facets */
        if (i == 0 || edges[i].from != edges[i - 1].from) {
            const wraps_edge *at = edges + i;
            size_t steps = 0;
            do {
                const pbw_index *f = w->facets + 3 * (size_t)at->facet;
                const pbw_index last = f[0] == at->from ? f[2] : f[1] == at->from ? f[0] : f[1];
                at = wraps_find(edges, count, edges[i].from, last);
                steps++;
            } while (at != NULL && at != edges + i && steps <= count);
            good = at != NULL && steps == degree[edges[i].from];
        }
    }
    for (i = 0; good && i < w->vertex_count; i++) {
        good = degree[i] > 0;
    }
    free(edges);
    free(degree);
    return good;
}

/* Whether tetrahedra are positive, fit, and have the facets as their boundary, turned outward. */
static int wraps_is_filled(const pbw_wrap_result *w)
{
    size_t t, i, k, facet = 0;
    for (t = 0; t < w->tet_count; t++) {
        const pbw_index *c = w->corners + 4 * t;
        if (c[0] >= w->point_count || c[1] >= w->point_count || c[2] >= w->point_count || c[3] >= w->point_count
            || pbw_orient3(w->points + 3 * (size_t)c[0], w->points + 3 * (size_t)c[1], w->points + 3 * (size_t)c[2],
                           w->points + 3 * (size_t)c[3]) <= 0) {
            return 0;
        }
        for (i = 0; i < 4; i++) {
            const pbw_index next = w->neighbors[4 * t + i];
            if (next == PBW_NONE) {
                for (k = 0; k < 3; k++) {
                    if (facet >= w->facet_count || w->facets[3 * facet + k] != c[PBW_FACET_CORNER(i, k)]) {
                        return 0;
                    }
                }
                facet++;
            } else {
                for (k = 0; k < 4 && (next >= w->tet_count || w->neighbors[4 * (size_t)next + k] != t); k++) {
                }
                if (k == 4) {
                    return 0;
                }
            }
        }
    }
    return facet == w->facet_count;
}

/* Returns what is wrong with a wrap of the input, NULL if nothing is.  inside: of how many elements a corner is
   tested for being inside. */
WRAPS_UNUSED static const char *wraps_fault(const pbw_wrap_input *in, const pbw_wrap_result *w, size_t inside)
{
    const size_t elements = wraps_elements(in), step = elements / inside + 1;
    size_t f, e, k;
    const double *c[3], *g[3];
    if (w->facet_count == 0 || w->vertex_count == 0) {
        return "there is no surface";
    }
    if (!wraps_is_manifold(w)) {
        return "the surface is no closed, oriented manifold";
    }
    if (!wraps_is_filled(w)) {
        return "tetrahedra do not fill the surface";
    }
    for (f = 0; f < w->facet_count; f++) {
        for (k = 0; k < 3; k++) {
            c[k] = w->points + 3 * (size_t)w->facets[3 * f + k];
        }
        if (w->elements[f] >= elements) {
            return "a facet has no element";
        }
        for (e = 0; e < elements; e++) {
            wraps_element(in, e, g);
            if (wraps_meet(c, g)) {
                return "a facet meets an element";
            }
        }
    }
    for (e = 0; e < elements; e += step) {
        wraps_element(in, e, g);
        if (wraps_inside(w, g[e / step % 3]) != 1) {
            return "an element is not inside";
        }
    }
    return NULL;
}

/* ---- soups ---- */

enum { WRAPS_POINTS = 60, WRAPS_ELEMENTS = 90 };

typedef struct wraps_soup {
    double points[3 * WRAPS_POINTS];
    pbw_index triangles[3 * WRAPS_ELEMENTS], segments[2 * WRAPS_ELEMENTS], singles[WRAPS_ELEMENTS];
    pbw_wrap_input in;
    pbw_wrap_options how;
} wraps_soup;

/* Fills a soup by a random number: a few points on a grid, in a plane, on a line, near each other, or anywhere. */
WRAPS_UNUSED static void wraps_make(wraps_soup *s, uint64_t key)
{
    const unsigned kind = (unsigned)(pbw_random(key, 0) % 6), shift = (unsigned)(pbw_random(key, 1) % 8);
    const size_t points = 1 + pbw_random(key, 2) % (key % 2 != 0 ? 8 : WRAPS_POINTS);
    uint64_t next = 100;
    size_t i;
    memset(s, 0, sizeof *s);
    s->in.points = s->points;
    s->in.point_count = points;
    for (i = 0; i < 3 * points; i++) {
        const double x = (double)(pbw_random(key, next++) >> 11) * 0x1p-53;
        s->points[i] = (kind == 0 ? floor(4 * x) : kind == 1 && i % 3 == 2 ? 0.25
                        : kind == 3 ? floor(3 * x) + 1e-9 * x : x) + (shift == 0 ? 1e5 : 0);
        s->points[i] = kind == 2 && i % 3 > 0 ? s->points[i - 1] : s->points[i];
    }
    s->in.triangles = s->triangles;
    s->in.segments = s->segments;
    s->in.singles = s->singles;
    s->in.triangle_count = pbw_random(key, 3) % 3 == 0 ? 0 : pbw_random(key, 4) % (points + points / 2 + 1);
    s->in.segment_count = pbw_random(key, 5) % 2 == 0 ? 0 : pbw_random(key, 6) % (points + 1);
    s->in.single_count = s->in.triangle_count + s->in.segment_count == 0 ? points : pbw_random(key, 7) % 3;
    for (i = 0; i < 3 * s->in.triangle_count; i++) {
        s->triangles[i] = (pbw_index)(pbw_random(key, next++) % points);
    }
    for (i = 0; i < 2 * s->in.segment_count; i++) {
        s->segments[i] = (pbw_index)(pbw_random(key, next++) % points);
    }
    for (i = 0; i < s->in.single_count; i++) {
        s->singles[i] = (pbw_index)(pbw_random(key, next++) % points);
    }
    s->how.alpha = 0.2 + 0.5 * (double)(pbw_random(key, 8) % 16) / 8;
    s->how.offset = s->how.alpha / (double)(1 + pbw_random(key, 9) % 40);
    s->how.fast = pbw_random(key, 10) % 4 == 0;
}
#endif
