/* pbw_domains.c: domains in the plane, solids, better tetrahedra, faults of surfaces, and wraps. */
#include "pbw_python.h"

/* pbw_plane_make, or pbw_plane_from_triangles if there are some, and pbw_plane_smooth; the plane is freed by
   pbw_plane_free. */
int pbw_python_plane(const pbw_plane_input *input, const pbw_index *triangles, const pbw_index *regions,
                     size_t triangle_count, const plane_request *request, const volatile int *stop, pbw_plane *plane)
{
    pbw_status status;
    watch w = { stop, NULL };
    pbw_options build = { 0 };
    pbw_plane_options options = { 0 };
    build.threads = request->threads;
    build.progress = pbw_python_progress;
    build.progress_user = &w;
    options.build = &build;
    options.rule = (pbw_plane_rule)request->rule;
    options.flags = request->flags;
    options.angle = request->angle;
    options.area = request->area;
    options.steiner_limit = request->steiner_limit;
    options.most = request->most;
    status = triangles == NULL ? pbw_plane_make(input, &options, plane)
           : pbw_plane_from_triangles(input, triangles, regions, triangle_count, &options, plane);
    if (status == PBW_OK && request->rounds > 0) {
        status = pbw_plane_smooth(plane, (pbw_plane_way)request->way, request->rounds, NULL, &options);
    }
    return (int)status;
}

static pbw_options watched(const watch *w)
{
    pbw_options options = { 0 };
    options.progress = pbw_python_progress;
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

int pbw_python_crossings(const double *points, size_t point_count, const pbw_index *triangles, size_t triangle_count,
                         int threads, const watch *w, pbw_surface_faults *faults)
{
    pbw_options options = watched(w);
    options.threads = threads;
    return (int)pbw_surface_crossings(points, point_count, triangles, triangle_count, &options, faults);
}

int pbw_python_fill(const pbw_fill_input *input, const pbw_fill_options *how, const watch *w, pbw_filled *filled,
                    pbw_fill_report *report)
{
    const pbw_options options = watched(w);
    return (int)pbw_fill(input, how, &options, filled, report);
}

int pbw_python_wrap(const pbw_wrap_input *input, const pbw_wrap_options *how, const watch *w, pbw_wrap_result *wrap,
                    pbw_wrap_report *report)
{
    const pbw_options options = watched(w);
    return (int)pbw_wrap(input, how, &options, wrap, report);
}

int pbw_python_wrap_solid(const pbw_wrap_input *input, const pbw_wrap_solid_options *how, const watch *w,
                          pbw_tets *mesh, pbw_wrap_solid_report *report)
{
    const pbw_options options = watched(w);
    return (int)pbw_wrap_solid(input, how, &options, mesh, report);
}
