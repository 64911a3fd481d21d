/* wraps.c: wraps of models, checked exactly.
   In: files with faces.  Out: a line for each: facets, seconds of tree and wrap, seconds of the check, and a fault if
   there is one: the wrap is no closed, oriented manifold that its tetrahedra fill; a facet of it meets a face of the
   model, or another facet; or a corner of a face is not inside.  Exit status 1 if a wrap has a fault. */
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_WRAP_IMPLEMENTATION
#include "pbw_wrap.h"
#include "pbw_io.h"
#include "../tests/wraps.h"
#include <stdio.h>

/* Whether facets meet faces, or each other, by pbw_surface_crossings of both together, or memory is out. */
static int touches(const pbw_wrap_input *in, const pbw_wrap_result *w)
{
    const size_t points = in->point_count + w->point_count, triangles = in->triangle_count + w->facet_count;
    double *x = (double *)malloc(3 * points * sizeof *x);
    pbw_index *ids = (pbw_index *)malloc(3 * triangles * sizeof *ids);
    pbw_surface_faults faults;
    size_t i;
    int good = x != NULL && ids != NULL;
    memset(&faults, 0, sizeof faults);
    if (good) {
        memcpy(x, in->points, 3 * in->point_count * sizeof *x);
        memcpy(x + 3 * in->point_count, w->points, 3 * w->point_count * sizeof *x);
        memcpy(ids, in->triangles, 3 * in->triangle_count * sizeof *ids);
        for (i = 0; i < 3 * w->facet_count; i++) {
            ids[3 * in->triangle_count + i] = w->facets[i] + (pbw_index)in->point_count;
        }
        good = pbw_surface_crossings(x, points, ids, triangles, NULL, &faults) == PBW_OK;
    }
    for (i = 0; i < faults.crossing_count; i++) {        /* the higher one is second */
        good = good && faults.crossings[2 * i + 1] < in->triangle_count;
    }
    for (i = 0; i < faults.flat_count; i++) {
        good = good && faults.flat[i] < in->triangle_count;
    }
    pbw_surface_faults_free(&faults);
    free(x);
    free(ids);
    return !good;
}

static int encloses(const pbw_wrap_input *in, const pbw_wrap_result *w)
{
    pbw_surface surface;
    size_t i;
    int good = pbw_surface_create(w->points, w->point_count, w->facets, w->facet_count, NULL, &surface) == PBW_OK;
    for (i = 0; i < 3 * in->triangle_count && good; i++) {
        good = pbw_surface_turns(&surface, in->points + 3 * (size_t)in->triangles[i]) == 1;
    }
    pbw_surface_free(&surface);
    return good;
}

int main(int argc, char **argv)
{
    int i, status = 0;
    printf("%-34s %8s %8s %8s  %s\n", "model", "facets", "wrap s", "check s", "outcome");
    for (i = 1; i < argc; i++) {
        const char *fault, *slash = strrchr(argv[i], '/'), *name = slash != NULL ? slash + 1 : argv[i];
        pbwio_cloud cloud;
        pbwio_error error;
        pbw_wrap_input in;
        pbw_wrap_report r;
        pbw_wrap_result w;
        pbw_status made;
        clock_t start;
        memset(&in, 0, sizeof in);
        if (pbwio_read(argv[i], NULL, &cloud, &error) != PBWIO_OK || cloud.dim != 3 || cloud.triangle_count == 0) {
            printf("%-34s no faces\n", name);
            pbwio_free(&cloud);
            continue;
        }
        in.points = cloud.points;
        in.point_count = cloud.count;
        in.triangles = cloud.triangles;
        in.triangle_count = cloud.triangle_count;
        made = pbw_wrap(&in, NULL, NULL, &w, &r);
        start = clock();
        fault = made != PBW_OK ? pbw_status_string(made) : !wraps_is_manifold(&w) ? "FAULT: no manifold"
              : !wraps_is_filled(&w) ? "FAULT: not filled" : touches(&in, &w) ? "FAULT: it meets the model"
              : !encloses(&in, &w) ? "FAULT: a corner is not inside" : NULL;
        printf("%-34s %8zu %8.2f %8.2f  %s\n", name, w.facet_count, r.seconds[0] + r.seconds[1],
               (double)(clock() - start) / CLOCKS_PER_SEC, fault != NULL ? fault : "good");
        fflush(stdout);
        status |= fault != NULL;
        pbw_wrap_free(&w);
        pbwio_free(&cloud);
    }
    return status;
}
