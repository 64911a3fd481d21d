/* pbw_python.h: what the shared library of the Python package pbw offers to ctypes; see pbw_python.c. */
#ifndef PBW_PYTHON_H
#define PBW_PYTHON_H
#include "pbw.h"
#include "pbw_check.h"
#include "pbw_query.h"
#include "pbw_live.h"
#include "pbw_cells.h"
#include "pbw_mesh2.h"
#include "pbw_adapt2.h"
#include "pbw_surface.h"
#include "pbw_improve.h"
#include "pbw_mesh3.h"
#include "pbw_fill.h"
#include "pbw_wrap.h"
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

typedef struct plane_request {            /* of pbw_plane_options */
    int rule, threads;
    unsigned flags;
    double angle, area;
    size_t steiner_limit;
    double most;
    int way, rounds;                   /* of smoothing */
} plane_request;

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
int pbw_python_nearest(const arrays *a, const size_t *first, const int32_t *item, const double *queries, size_t count,
                       size_t k, int32_t *points, double *distances);
int pbw_python_coordinates(const arrays *a, const double *queries, size_t count, int scheme, pbw_lists *lists);
int pbw_python_cells(const arrays *a, const double *box, const double *lattice, unsigned periodic, unsigned what,
                     pbw_cells *cells);
int pbw_python_gpu_cells(const arrays *a, const double *box, unsigned axes, int facets, pbw_cells *cells,
                         char *message, size_t size);
void pbw_python_gpu_free(pbw_cells *cells);
int pbw_python_stars(const arrays *a, pbw_lists *stars);
int pbw_python_check(const arrays *a, int *valid);
int pbw_python_plane(const pbw_plane_input *input, const pbw_index *triangles, const pbw_index *regions,
                     size_t triangle_count, const plane_request *request, const volatile int *stop, pbw_plane *plane);
int pbw_python_improve(const pbw_tets *mesh, const pbw_improve_options *how, const watch *w, char message[128],
                       pbw_tets *better, pbw_improve_report *report);
int pbw_python_solid(const pbw_solid_input *input, const pbw_solid_options *how, const watch *w, pbw_tets *mesh,
                     pbw_solid_boundary *boundary, pbw_solid_report *report);
int pbw_python_crossings(const double *points, size_t point_count, const pbw_index *triangles, size_t triangle_count,
                         int threads, const watch *w, pbw_surface_faults *faults);
int pbw_python_fill(const pbw_fill_input *input, const pbw_fill_options *how, const watch *w, pbw_filled *filled,
                    pbw_fill_report *report);
int pbw_python_wrap(const pbw_wrap_input *input, const pbw_wrap_options *how, const watch *w, pbw_wrap_result *wrap,
                    pbw_wrap_report *report);
int pbw_python_wrap_solid(const pbw_wrap_input *input, const pbw_wrap_solid_options *how, const watch *w,
                          pbw_tets *mesh, pbw_wrap_solid_report *report);

/* For the files of the library alone. */
int pbw_python_progress(void *user, pbw_stage stage, double done);
void pbw_python_view(const arrays *a, pbw_mesh *mesh, pbw_options *options, watch *w);
#endif
