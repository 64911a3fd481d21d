/* rival_qhull.c: Qhull's Delaunay triangulation (one thread, at most 1e5 points)

   The options are those of SciPy: Qbb scales the lift, Qz adds a point at infinity for cospherical input, Qt
   triangulates what was merged, Q12 allows wide facets.  Qhull merges facets that are flat within rounding error, so
   its number of simplices may differ from the exact one. */
#include "bench.h"

#include <libqhull_r/libqhull_r.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct job {
    bench_input input;
    double *points;
    FILE *sink;
    qhT state;
    int built, code;
} job;

static int fits(const bench_input *input)
{
    return input->threads == 1 && !input->weights && input->count <= 100000;
}

static void *prepare(const bench_input *input)
{
    size_t bytes = input->count * (size_t)input->dim * sizeof(double);
    job *made = (job *)calloc(1, sizeof *made);
    if (!made || !(made->points = (double *)malloc(bytes)) || !(made->sink = fopen("/dev/null", "w"))) {
        abort();
    }
    made->input = *input;
    memcpy(made->points, input->points, bytes);
    return made;
}

static void build(void *that)
{
    static char options[] = "qhull d Qt Qbb Qz Q12";
    job *made = (job *)that;
    qh_zero(&made->state, made->sink);
    made->code = qh_new_qhull(&made->state, made->input.dim, (int)made->input.count, made->points, 0, options,
                              made->sink, made->sink);
    made->built = 1;
}

static void discard(void *that)
{
    job *made = (job *)that;
    if (made->built) {
        qh_freeqhull(&made->state, qh_ALL);
    }
    made->built = 0;
}

static void report(void *that, bench_sample *sample)
{
    job *made = (job *)that;
    const facetT *facet;
    if (made->code) {
        snprintf(sample->failure, sizeof sample->failure, "Qhull error %d", made->code);
        return;
    }
    for (facet = made->state.facet_list; facet && facet->next; facet = facet->next) {
        sample->simplices += !facet->upperdelaunay;
    }
}

const bench_side bench_qhull = { "Qhull", 0, fits, prepare, build, discard, report };
