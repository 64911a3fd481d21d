/* pbw_gpu.c: see pbw_python.c.  Cells by a GPU, in a library that was built with pbw_cuda.cu. */
#include "pbw_python.h"
#include <stdio.h>

/* The cells of points in a box, which repeats along axes, or with NULL in the whole space, by a GPU: volumes and
   centroids, and with facets first, neighbors and areas; for pbw_python_gpu_free.  message: why it fails. */
#ifdef PBW_CUDA
int pbw_python_gpu_cells(const arrays *a, const double *box, unsigned axes, int facets, pbw_cells *cells,
                         char *message, size_t size)
{
    pbw_mesh mesh;
    pbw_options options;
    pbw_cuda_cells made;
    watch w;
    pbw_python_view(a, &mesh, &options, &w);
    options.message = message;
    options.message_size = size;
    const pbw_status status = pbw_cuda_cells_of_host(a->dim, a->points, a->weights, a->point_count, box, axes,
                                                     facets ? PBW_CUDA_FACETS : 0, &options, pbw_triangulate, &made);
    *cells = (pbw_cells){ .dim = made.dim, .cell_count = made.cell_count, .facet_count = made.facet_count,
                          .volumes = made.volumes, .centroids = made.centroids, .first = made.first,
                          .neighbors = made.neighbors, .areas = made.areas, .sites = made.sites,
                          .shifts = made.shifts, .memory = made.memory };
    return (int)status;
}

void pbw_python_gpu_free(pbw_cells *cells)
{
    pbw_cuda_cells made = { .memory = cells->memory };
    pbw_cuda_cells_free(&made, NULL);
    *cells = (pbw_cells){ 0 };
}
#else
int pbw_python_gpu_cells(const arrays *a, const double *box, unsigned axes, int facets, pbw_cells *cells,
                         char *message, size_t size)
{
    (void)a, (void)box, (void)axes, (void)facets, (void)cells;
    snprintf(message, size, "pbw was built without CUDA: PBW_CUDA=1 pip install ./examples/python builds it so");
    return (int)PBW_ERROR_BACKEND;
}

void pbw_python_gpu_free(pbw_cells *cells)
{
    (void)cells;
}
#endif
