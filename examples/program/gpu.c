/* gpu.c: cells by a GPU, in a program that `make GPU=1` built with pbw_cuda.cu.
   In: the points of a job, a domain.  Out: volumes, centroids, neighbours and areas of their cells. */
#include "program.h"

#ifdef PBW_CUDA
int gpu_cells(job *j, const pbw_domain *domain, pbw_cells *cells)
{
    const pbwio_cloud *c = &j->cloud;
    char message[256] = "";
    pbw_options options = j->build;
    pbw_cuda_cells made;
    pbw_status status;
    options.message = message;
    options.message_size = sizeof message;
    begin(j, "cells", "mesh and cells on the GPU");
    status = pbw_cuda_cells_of_host(c->dim, c->points, c->weights, c->count, domain->box, domain->periodic,
                                    PBW_CUDA_FACETS, &options, pbw_triangulate, &made);
    if (status == PBW_ERROR_BACKEND) {
        return fail(j, "--gpu: %s", message[0] != 0 ? message : pbw_status_string(status));
    }
    if (status == PBW_DEGENERATE && c->count > 0) {
        return fail(j, "the points do not span the %s; with --box they have cells", c->dim == 3 ? "space" : "plane");
    }
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        return explain(j, status);
    }
    cells->dim = made.dim;
    cells->cell_count = made.cell_count;
    cells->facet_count = made.facet_count;
    cells->volumes = made.volumes;
    cells->centroids = made.centroids;
    cells->first = made.first;
    cells->neighbors = made.neighbors;
    cells->areas = made.areas;
    cells->sites = made.sites;
    cells->shifts = made.shifts;
    cells->memory = made.memory;
    return 0;
}

void gpu_free(pbw_cells *cells)
{
    pbw_cuda_cells made;
    memset(&made, 0, sizeof made);
    made.memory = cells->memory;
    pbw_cuda_cells_free(&made, NULL);
    memset(cells, 0, sizeof *cells);
}
#else
int gpu_cells(job *j, const pbw_domain *domain, pbw_cells *cells)
{
    (void)domain;
    (void)cells;
    return fail(j, "--gpu: this program was built without CUDA; `make GPU=1 B=build/gpu` builds one with it");
}

void gpu_free(pbw_cells *cells)
{
    memset(cells, 0, sizeof *cells);
}
#endif
