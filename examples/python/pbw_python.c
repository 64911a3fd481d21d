/* pbw_python.c: pbw.h and its companion headers as a shared library for the Python package pbw: a triangulation
   copied into arrays that Python owns, and what is computed from these.
   cc -O2 -I. -Iexamples/lib -fPIC -shared examples/python/pbw_python.c -o libpbw_python.so -lpthread -lm */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_MESH3_IMPLEMENTATION
#include "pbw_mesh3.h"
#include <stdlib.h>
#include <string.h>

/* Python has indices in 32 signed bits, as SciPy does; -1 has the bits of PBW_NONE. */
typedef struct arrays {
    int dim, threads;
    size_t point_count, simplex_count;
    const double *points, *weights;    /* weights: or NULL */
    const int32_t *simplices, *neighbors, *incident, *canonical;
    const volatile int *stop;          /* as in watch */
} arrays;

typedef struct watch {
    const volatile int *stop;          /* set by another thread, for Ctrl-C */
    int (*progress)(int stage, double done);       /* or NULL */
} watch;

typedef struct plane_wish {            /* of pbw_plane_options */
    int rule, threads;
    unsigned flags;
    double angle, area;
    size_t steiner_limit;
} plane_wish;

size_t pbw_python_size(int structure);
pbw_mesh *pbw_python_build(int dim, const double *points, const double *weights, size_t count, int threads,
                           const volatile int *stop, int (*progress)(int stage, double done), int *status,
                           size_t *simplices);
void pbw_python_copy(const pbw_mesh *mesh, int32_t *simplices, int32_t *neighbors, int32_t *incident,
                     int32_t *canonical);
void pbw_python_free(pbw_mesh *mesh);
int pbw_python_live(const arrays *a, const watch *w, pbw_live **live);
pbw_mesh *pbw_python_live_view(pbw_live *live, int *status, size_t *points, size_t *simplices);
void pbw_python_copy_points(const pbw_mesh *mesh, double *points, double *weights);
void pbw_python_try_all(const arrays *mesh, const double *queries, size_t count, int32_t *found);
int pbw_python_locate(const arrays *a, const double *queries, size_t count, int32_t *found, int32_t *facets);
int pbw_python_nearest(const arrays *a, const double *queries, size_t count, size_t k, int32_t *points,
                       double *distances);
int pbw_python_coordinates(const arrays *a, const double *queries, size_t count, int scheme, pbw_lists *lists);
int pbw_python_cells(const arrays *a, const double *box, unsigned periodic, unsigned what, pbw_cells *cells);
int64_t pbw_python_stars(const arrays *mesh, int32_t *indptr, int32_t *indices);
int pbw_python_plane(const pbw_plane_input *input, const plane_wish *wish, const volatile int *stop, pbw_plane *plane);
int pbw_python_improve(const pbw_tets *mesh, const pbw_improve_options *how, const watch *w, char message[128],
                       pbw_tets *better, pbw_improve_report *report);
int pbw_python_solid(const pbw_solid_input *input, const pbw_solid_options *how, const watch *w, pbw_tets *mesh,
                     pbw_solid_boundary *boundary, pbw_solid_report *report);

/* Sizes of the structures that Python declares too, in the order of _library.py and _tets.py; 0 beyond. */
size_t pbw_python_size(int structure)
{
    static const size_t size[] = {
        sizeof(arrays), sizeof(pbw_lists), sizeof(pbw_cells), sizeof(pbw_plane_input), sizeof(plane_wish),
        sizeof(watch), sizeof(pbw_changes), sizeof(pbw_plane), sizeof(pbw_tets), sizeof(pbw_quality),
        sizeof(pbw_improve_options), sizeof(pbw_improve_report), sizeof(pbw_solid_input), sizeof(pbw_solid_options),
        sizeof(pbw_solid_report), sizeof(pbw_solid_boundary)
    };
    return structure >= 0 && (size_t)structure < sizeof size / sizeof *size ? size[structure] : 0;
}

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
    if (bytes > 0) {
        memcpy(simplices, mesh->simplices, bytes);
        memcpy(neighbors, mesh->neighbors, bytes);
    }
    if (mesh->point_count > 0) {
        memcpy(incident, mesh->incident, mesh->point_count * sizeof(int32_t));
        memcpy(canonical, mesh->canonical, mesh->point_count * sizeof(int32_t));
    }
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

/* For each query the lowest simplex that has it, found by trying all in turn; -1 if it is outside of the hull. */
void pbw_python_try_all(const arrays *mesh, const double *queries, size_t count, int32_t *found)
{
    for (size_t i = 0; i < count; i++) {
        found[i] = -1;
        for (size_t t = 0; found[i] < 0 && t < mesh->simplex_count; t++) {
            int inside = 1;
            for (int k = 0; k <= mesh->dim && inside; k++) {
                inside = side(mesh, (int32_t)t, k, queries + i * (size_t)mesh->dim) >= 0;
            }
            found[i] = inside ? (int32_t)t : -1;
        }
    }
}

/* The library's view of Python's arrays, and options that end its work when Python says so. */
static void view(const arrays *a, pbw_mesh *mesh, pbw_options *options, watch *w)
{
    memset(mesh, 0, sizeof *mesh);
    memset(options, 0, sizeof *options);
    mesh->dim = a->dim;
    mesh->point_count = a->point_count;
    mesh->simplex_count = a->simplex_count;
    mesh->simplices = (const pbw_index *)a->simplices;
    mesh->neighbors = (const pbw_index *)a->neighbors;
    mesh->incident = (const pbw_index *)a->incident;
    mesh->canonical = (const pbw_index *)a->canonical;
    mesh->points = a->points;
    mesh->weights = a->weights;
    w->stop = a->stop;
    w->progress = NULL;
    options->threads = a->threads;
    options->progress = on_progress;
    options->progress_user = w;
}

/* For each query the lowest simplex that has it, or -1 - t if it is outside of the hull, t being a simplex at it to
   that side.  facets: room for as many. */
int pbw_python_locate(const arrays *a, const double *queries, size_t count, int32_t *found, int32_t *facets)
{
    pbw_mesh mesh;
    pbw_options options;
    watch w;
    view(a, &mesh, &options, &w);
    int status = (int)pbw_locate(&mesh, queries, count, &options, (pbw_index *)found, (pbw_index *)facets);
    for (size_t i = 0; status == (int)PBW_OK && i < count; i++) {
        found[i] = found[i] < 0 ? -1 - (int32_t)((pbw_index)facets[i] / (pbw_index)(a->dim + 1)) : found[i];
    }
    return status;
}

int pbw_python_nearest(const arrays *a, const double *queries, size_t count, size_t k, int32_t *points,
                       double *distances)
{
    pbw_mesh mesh;
    pbw_options options;
    watch w;
    view(a, &mesh, &options, &w);
    return (int)pbw_nearest(&mesh, NULL, queries, count, k, &options, (pbw_index *)points, distances);
}

int pbw_python_coordinates(const arrays *a, const double *queries, size_t count, int scheme, pbw_lists *lists)
{
    pbw_mesh mesh;
    pbw_options options;
    watch w;
    view(a, &mesh, &options, &w);
    return (int)pbw_coordinates(&mesh, queries, count, (pbw_scheme)scheme, &options, lists);
}

/* box: NULL = the whole space.  periodic: bits of axes; then only the points of the arrays count. */
int pbw_python_cells(const arrays *a, const double *box, unsigned periodic, unsigned what, pbw_cells *cells)
{
    pbw_mesh mesh;
    pbw_options options;
    pbw_domain domain = { 0 };
    watch w;
    view(a, &mesh, &options, &w);
    domain.box = box;
    domain.periodic = periodic;
    return (int)(periodic == 0 ? pbw_cells_of(&mesh, &domain, what, &options, cells)
                 : pbw_cells_periodic(a->dim, a->points, a->weights, a->point_count, &domain, what, &options, cells));
}

static pbw_options watched(const watch *w)
{
    pbw_options options = { 0 };
    options.progress = on_progress;
    options.progress_user = (void *)(uintptr_t)w;
    return options;
}

int pbw_python_improve(const pbw_tets *mesh, const pbw_improve_options *how, const watch *w, char message[128],
                       pbw_tets *better, pbw_improve_report *report)
{
    pbw_options options = watched(w);
    options.message = message;
    options.message_size = 128;
    return (int)pbw_improve(mesh, how, &options, better, report);
}

int pbw_python_solid(const pbw_solid_input *input, const pbw_solid_options *how, const watch *w, pbw_tets *mesh,
                     pbw_solid_boundary *boundary, pbw_solid_report *report)
{
    const pbw_options options = watched(w);
    return (int)pbw_solid(input, how, &options, mesh, boundary, report);
}

/* A live triangulation of a mesh, or of no points.  The watch must outlive it; pbw_live_free it. */
int pbw_python_live(const arrays *a, const watch *w, pbw_live **live)
{
    pbw_mesh mesh;
    pbw_options options;
    watch unused;
    view(a, &mesh, &options, &unused);
    options.progress_user = (void *)(uintptr_t)w;
    const pbw_status status = pbw_live_create(&mesh, &options, live);
    return (int)(status == PBW_DEGENERATE ? PBW_OK : status);
}

/* What it is now, as pbw_python_build; without simplices if *status is PBW_DEGENERATE. */
pbw_mesh *pbw_python_live_view(pbw_live *live, int *status, size_t *points, size_t *simplices)
{
    pbw_mesh *mesh = (pbw_mesh *)calloc(1, sizeof *mesh);
    *status = mesh == NULL ? (int)PBW_ERROR_MEMORY : (int)pbw_live_view(live, mesh);
    if (mesh != NULL && *status != PBW_OK && *status != PBW_DEGENERATE) {
        pbw_python_free(mesh);
        mesh = NULL;
    }
    *points = mesh != NULL ? mesh->point_count : 0;
    *simplices = mesh != NULL ? mesh->simplex_count : 0;
    return mesh;
}

/* weights: room for all, left alone where there are none. */
void pbw_python_copy_points(const pbw_mesh *mesh, double *points, double *weights)
{
    if (mesh->point_count > 0) {
        memcpy(points, mesh->points, mesh->point_count * (size_t)mesh->dim * sizeof(double));
    }
    if (mesh->weights != NULL) {
        memcpy(weights, mesh->weights, mesh->point_count * sizeof(double));
    }
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

/* pbw_plane_make; the plane is freed by pbw_plane_free. */
int pbw_python_plane(const pbw_plane_input *input, const plane_wish *wish, const volatile int *stop, pbw_plane *plane)
{
    watch w = { stop, NULL };
    pbw_options build = { 0 };
    pbw_plane_options options = { 0 };
    build.threads = wish->threads;
    build.progress = on_progress;
    build.progress_user = &w;
    options.build = &build;
    options.rule = (pbw_plane_rule)wish->rule;
    options.flags = wish->flags;
    options.angle = wish->angle;
    options.area = wish->area;
    options.steiner_limit = wish->steiner_limit;
    return (int)pbw_plane_make(input, &options, plane);
}
