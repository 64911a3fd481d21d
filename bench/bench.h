/* bench.h: what bench.c asks of a library that it measures

   A side is one library, used in one way.  bench.c calls, in a process of its own for each sample:

       job = prepare(input)               not timed: the points in the form that the library takes
       build(job)                         timed: from points in memory to the triangulation in memory
       discard(job)  build(job)  ...      discard is not timed; only small inputs are built more than once
       report(job, sample)                not timed: what came out of the last build

   A side may die, throw out of build or never return: the process ends, and the row says so. */
#ifndef BENCH_H
#define BENCH_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct bench_input {
    int dim, threads;
    size_t count;
    const double *points;                  /* dim coordinates each */
    const double *weights;                 /* NULL = Delaunay */
    size_t sets;                           /* of `count` points each, one after the other; a side sees the first */
    int check;                             /* 1: report checks the result as well as it can */
} bench_input;

typedef struct bench_sample {
    int done;                              /* set last; 0: the process ended before */
    char failure[120];                     /* "" = there is a triangulation */
    int checked;                           /* 1: found valid, exactly */
    double seconds;                        /* one build, the mean over the builds of this process */
    size_t simplices;                      /* without those at infinity */
    size_t resident;                       /* most memory the process gained during its first build, 0 = unknown */
    size_t held;                           /* the library's own count of its peak, 0 = it has none */
    uint64_t hash;                         /* of the triangulation, 0 = unknown */
    double phases[7];                      /* order, build, output; of the build: walk, cavity, star, exact tests */
    size_t counters[7];                    /* walk steps, sphere tests, exact sphere tests, simplices created; rounds,
                                              postponed insertions, insertions by one thread alone */
} bench_sample;

typedef struct bench_side {
    const char *name;
    int exact;                             /* 1: another number of simplices than ours is an error of one of us */
    int (*fits)(const bench_input *input); /* 0: no row for this input */
    void *(*prepare)(const bench_input *input);
    void (*build)(void *job);
    void (*discard)(void *job);
    void (*report)(void *job, bench_sample *sample);
} bench_side;

extern const bench_side bench_cgal, bench_cgal_tbb, bench_tetgen, bench_qhull;     /* those that were found */

#ifdef __cplusplus
}
#endif
#endif
