/* pbw_python.c: pbw.h as a shared library for the Python package pbw: a triangulation copied into arrays that Python
   owns, and the simplices that many points lie in.
   cc -O2 -I. -fPIC -shared examples/python/pbw_python.c -o libpbw_python.so -lpthread -lm */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdlib.h>
#include <string.h>

/* Python has indices in 32 signed bits, as SciPy does; -1 has the bits of PBW_NONE. */
typedef struct arrays {
    int dim;
    size_t point_count, simplex_count;
    const double *points;
    const int32_t *simplices, *neighbors;
} arrays;

typedef struct watch {
    const volatile int *stop;          /* set by another thread, for Ctrl-C */
    int (*progress)(int stage, double done);       /* or NULL */
} watch;

pbw_mesh *pbw_python_build(int dim, const double *points, const double *weights, size_t count, int threads,
                           const volatile int *stop, int (*progress)(int stage, double done), int *status,
                           size_t *simplices);
void pbw_python_copy(const pbw_mesh *mesh, int32_t *simplices, int32_t *neighbors, int32_t *incident,
                     int32_t *canonical);
void pbw_python_free(pbw_mesh *mesh);
int pbw_python_find(const arrays *mesh, const double *queries, size_t count, int every, int32_t *found);
int64_t pbw_python_stars(const arrays *mesh, int32_t *indptr, int32_t *indices);

static int on_progress(void *user, pbw_stage stage, double done)
{
    const watch *w = (const watch *)user;
    return *w->stop || (w->progress != NULL && w->progress((int)stage, done));
}

/* A mesh to copy and free before the points, and how many simplices it has; NULL on failure, *status says which. */
pbw_mesh *pbw_python_build(int dim, const double *points, const double *weights, size_t count, int threads,
                           const volatile int *stop, int (*progress)(int stage, double done), int *status,
                           size_t *simplices)
{
    watch w = { stop, progress };
    pbw_options options = { 0 };
    pbw_mesh *mesh = (pbw_mesh *)calloc(1, sizeof *mesh);
    *status = PBW_ERROR_MEMORY;
    *simplices = 0;
    if (mesh != NULL) {
        options.threads = threads;
        options.flags = PBW_BORROW;
        options.progress = on_progress;
        options.progress_user = &w;
        *status = (int)pbw_triangulate(dim, points, weights, count, &options, mesh);
        *simplices = mesh->simplex_count;
        if (*status != PBW_OK) {
            pbw_python_free(mesh);
            mesh = NULL;
        }
    }
    return mesh;
}

/* Fills the arrays, which have room for all simplices and all points. */
void pbw_python_copy(const pbw_mesh *mesh, int32_t *simplices, int32_t *neighbors, int32_t *incident,
                     int32_t *canonical)
{
    size_t bytes = mesh->simplex_count * (size_t)(mesh->dim + 1) * sizeof(int32_t);
    memcpy(simplices, mesh->simplices, bytes);
    memcpy(neighbors, mesh->neighbors, bytes);
    memcpy(incident, mesh->incident, mesh->point_count * sizeof(int32_t));
    memcpy(canonical, mesh->canonical, mesh->point_count * sizeof(int32_t));
}

void pbw_python_free(pbw_mesh *mesh)
{
    pbw_free(mesh);
    free(mesh);
}

/* The exact side of q to facet k of simplex t: +1 inside, 0 on it. */
static int side(const arrays *m, int32_t t, int k, const double *q)
{
    const int32_t *corner = m->simplices + (size_t)t * (size_t)(m->dim + 1);
    const double *p[4];
    for (int i = 0; i <= m->dim; i++) {
        p[i] = i == k ? q : m->points + (size_t)corner[i] * (size_t)m->dim;
    }
    return m->dim == 2 ? pbw_orient2(p[0], p[1], p[2]) : pbw_orient3(p[0], p[1], p[2], p[3]);
}

/* Walks from t through facets that have q on their far side, which ends since no such walk in a regular triangulation
   has a cycle (Edelsbrunner 1990, "An acyclicity theorem for cell complexes in d dimensions").  The simplex with q in
   it, or -1 - t if the walk leaves the hull from t.  *zero: a bit for each facet that q is on. */
static int32_t walk(const arrays *m, int32_t t, const double *q, int *zero)
{
    int32_t from = -1;
    for (;;) {
        const int32_t *neighbor = m->neighbors + (size_t)t * (size_t)(m->dim + 1);
        int k, far = 0;
        *zero = 0;
        for (k = 0; k <= m->dim && !far; k++) {
            int sign = from >= 0 && neighbor[k] == from ? 1 : side(m, t, k, q);
            far = sign < 0;
            *zero |= (sign == 0) << k;
        }
        if (!far) {
            return t;
        }
        from = t;
        t = neighbor[k - 1];
        if (t < 0) {
            return -1 - from;
        }
    }
}

/* The lowest of all simplices that have q, of which t is one: they hang together by facets that have q.  link: per
   simplex 0 if it was not seen yet, else one more than the simplex seen after it, or -1; all 0 again at the end. */
static int32_t lowest(const arrays *m, int32_t t, const double *q, int32_t *link)
{
    int32_t best = t, last = t, s, next;
    link[t] = -1;
    for (s = t; s >= 0; s = link[s] - (link[s] > 0)) {
        best = s < best ? s : best;
        for (int k = 0; k <= m->dim; k++) {
            int32_t n = m->neighbors[(size_t)s * (size_t)(m->dim + 1) + (size_t)k];
            if (n >= 0 && link[n] == 0 && side(m, s, k, q) == 0) {
                link[last] = n + 1;
                link[n] = -1;
                last = n;
            }
        }
    }
    for (s = t; s >= 0; s = next) {
        next = link[s] - (link[s] > 0);
        link[s] = 0;
    }
    return best;
}

/* For each query the lowest simplex that has it, or -1 - t if it is outside of the hull, t being a simplex to that
   side; each walk starts where the one before ended.  every: try all simplices in turn instead, for comparison.
   1 if there is no memory, else 0. */
int pbw_python_find(const arrays *mesh, const double *queries, size_t count, int every, int32_t *found)
{
    int32_t *link = (int32_t *)calloc(mesh->simplex_count, sizeof *link), at = 0;
    int dim = mesh->dim;
    for (size_t i = 0; link != NULL && i < count; i++) {
        const double *q = queries + i * (size_t)dim;
        int zero = 0, finite = 1;
        for (int k = 0; k < dim; k++) {
            finite &= q[k] - q[k] == 0.0;
        }
        found[i] = -1 - at;
        if (every && finite) {
            for (at = 0; found[i] < 0 && (size_t)at < mesh->simplex_count; at++) {
                int inside = 1;
                for (int k = 0; k <= dim && inside; k++) {
                    inside = side(mesh, at, k, q) >= 0;
                }
                found[i] = inside ? at : found[i];
            }
            at = 0;
        } else if (finite) {
            found[i] = walk(mesh, at, q, &zero);
            found[i] = zero != 0 && found[i] >= 0 ? lowest(mesh, found[i], q, link) : found[i];
            at = found[i] < 0 ? -1 - found[i] : found[i];
        }
    }
    free(link);
    return link == NULL;
}

/* The neighbours of each point p, ascending, in indices[indptr[p]] to indices[indptr[p + 1] - 1].  Point by point,
   its number is appended to the rows of its neighbours, for each is the other's.  The length of indices, which may be
   NULL in a first call for indptr alone; -1 if there is no memory, or if the length is above 2^31 - 1. */
int64_t pbw_python_stars(const arrays *mesh, int32_t *indptr, int32_t *indices)
{
    size_t corners = (size_t)mesh->dim + 1, total = mesh->simplex_count * corners, points = mesh->point_count;
    const int32_t *simplices = mesh->simplices;
    size_t *first = (size_t *)calloc(points + 2, sizeof *first);     /* of a point's simplices in around */
    int32_t *around = (int32_t *)malloc((total + 1) * sizeof *around);
    int32_t *seen = (int32_t *)calloc(points + 1, sizeof *seen);     /* one more than the last point beside it */
    int64_t length = -1;
    if (first != NULL && around != NULL && seen != NULL) {
        for (size_t i = 0; i < total; i++) {
            first[simplices[i] + 2]++;
        }
        for (size_t p = 0; p < points; p++) {
            first[p + 2] += first[p + 1];
        }
        for (size_t i = 0; i < total; i++) {
            around[first[simplices[i] + 1]++] = (int32_t)(i / corners);
        }
        length = 0;
        for (size_t p = 0; p < points; p++) {
            if (indices == NULL) {
                indptr[p] = (int32_t)length;
            }
            for (size_t i = first[p]; i < first[p + 1]; i++) {
                for (size_t k = 0; k < corners; k++) {
                    int32_t q = simplices[(size_t)around[i] * corners + k];
                    if (q != (int32_t)p && seen[q] != (int32_t)p + 1) {
                        seen[q] = (int32_t)p + 1;
                        length++;
                        if (indices != NULL) {
                            indices[indptr[q]++] = (int32_t)p;       /* a row's beginning moves to the next one's */
                        }
                    }
                }
            }
        }
        if (indices == NULL) {
            indptr[points] = (int32_t)length;
        } else {
            memmove(indptr + 1, indptr, points * sizeof *indptr);
            indptr[0] = 0;
        }
    }
    free(first);
    free(around);
    free(seen);
    return length > INT32_MAX ? -1 : length;
}
