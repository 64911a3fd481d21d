/* pbw_python.c: pbw.h and its companion headers as a shared library for the Python package pbw.  This file
   makes triangulations and copies them into arrays that Python owns.  pbw_queries.c computes from these arrays;
   pbw_domains.c meshes domains.
   cc -O2 -I. -Iexamples/lib -fPIC -shared examples/python/pbw_*.c -o libpbw_python.so -lpthread -lm */
#define PBW_IMPLEMENTATION
#define PBW_CHECK_IMPLEMENTATION
#define PBW_QUERY_IMPLEMENTATION
#define PBW_LIVE_IMPLEMENTATION
#define PBW_CELLS_IMPLEMENTATION
#define PBW_MESH2_IMPLEMENTATION
#define PBW_ADAPT2_IMPLEMENTATION
#define PBW_SURFACE_IMPLEMENTATION
#define PBW_IMPROVE_IMPLEMENTATION
#define PBW_MESH3_IMPLEMENTATION
#define PBW_FILL_IMPLEMENTATION
#define PBW_WRAP_IMPLEMENTATION
#include "pbw_python.h"

/* Sizes of the structures that Python declares too, in the order of _library.py, _tets.py, _surface.py and _wrap.py;
   0 beyond. */
size_t pbw_python_size(int structure)
{
    static const size_t size[] = {
        sizeof(arrays), sizeof(pbw_lists), sizeof(pbw_cells), sizeof(pbw_plane_input), sizeof(plane_request),
        sizeof(watch), sizeof(pbw_changes), sizeof(pbw_plane), sizeof(pbw_tets), sizeof(pbw_quality),
        sizeof(pbw_improve_options), sizeof(pbw_improve_report), sizeof(pbw_solid_input), sizeof(pbw_solid_options),
        sizeof(pbw_solid_report), sizeof(pbw_solid_boundary), sizeof(pbw_surface_faults), sizeof(pbw_wrap_input),
        sizeof(pbw_wrap_options), sizeof(pbw_wrap_result), sizeof(pbw_wrap_report),
        sizeof(pbw_fill_input), sizeof(pbw_fill_options), sizeof(pbw_fill_report), sizeof(pbw_filled),
        sizeof(pbw_wrap_solid_options), sizeof(pbw_wrap_solid_report)
    };
    return structure >= 0 && (size_t)structure < sizeof size / sizeof *size ? size[structure] : 0;
}

int pbw_python_progress(void *user, pbw_stage stage, double done)
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
        options.progress = pbw_python_progress;
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

/* The library's view of Python's arrays, and options that end its work when Python says so. */
void pbw_python_view(const arrays *a, pbw_mesh *mesh, pbw_options *options, watch *w)
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
    options->progress = pbw_python_progress;
    options->progress_user = w;
}

/* A live triangulation of a mesh, or of no points.  The watch must outlive it; pbw_live_free it. */
int pbw_python_live(const arrays *a, const watch *w, pbw_live **live)
{
    pbw_mesh mesh;
    pbw_options options;
    watch unused;
    pbw_python_view(a, &mesh, &options, &unused);
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
