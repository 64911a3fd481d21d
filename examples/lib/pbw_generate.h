/* pbw_generate.h - v0.2.0 - points in many patterns, for trials - MIT-0

   QUICK START
   Include it; every function is static.  Needs pbw_io.h, with its implementation in some source file.

       pbwio_cloud cloud = {0};
       const pbw_status status = pbwgen_points(3, 3, 1000000, 1, NULL, &cloud);      // kind 3: sphere; in 3D, seed 1
       if (status != PBW_OK) puts(pbw_status_string(status));
       pbwio_free(&cloud);

   FUNCTIONS
     pbwgen_points  makes points of a kind

   CONTENTS  (search for the marks)
     >>random       random numbers
     >>kinds        the kinds by name; a point of each
     >>cloud        the points of a cloud

   HOW
     Coordinates are sums, products and elementary functions of uniform random numbers, of the number of the point, or
     both; pbwgen_kinds has the names of the kinds, by which the pbw command takes them.

   PROMISES  (tests/program.sh and tests/hashes_lib.c guard them)
     same        points are a function of kind, dimension, count and seed alone
     bounded     a call holds at most options.memory_limit, and nothing after a failure
     quiet       no globals, nothing printed, no exit
*/
#ifndef PBW_GENERATE_H
#define PBW_GENERATE_H
#include "pbw_io.h"
#include <math.h>
#include <string.h>

/* ------------------------------------------------------------------------------------------------------
   >>random       Random numbers.
   In: a counter.  Out: a number in [0, 1), or a nearly normal one.
   Holds: a number is a function of the counter alone.
   ------------------------------------------------------------------------------------------------------ */

static double pbwgen__mixed(uint64_t z)
{
    return (double)(pbw_random(0, z - 1) >> 11) / 9007199254740992.0;
}

static double pbwgen__uniform(uint64_t *state)
{
    return pbwgen__mixed(++*state);
}

static double pbwgen__gauss(uint64_t *state)                         /* nearly: the sum of twelve uniform ones */
{
    double sum = -6;
    int i;
    for (i = 0; i < 12; i++) {
        sum += pbwgen__uniform(state);
    }
    return sum;
}

/* ------------------------------------------------------------------------------------------------------
   >>kinds        The kinds by name, and a point of each.
   In: a kind, the number of a point.  Out: its coordinates.
   Holds: a point takes its random numbers from the state, so points are made in the order of their numbers.
   ------------------------------------------------------------------------------------------------------ */

static const char *const pbwgen_kinds[] = { "uniform", "gauss", "ball", "sphere", "lattice", "clusters", "lines",
                                            "spiral", "plane", "anisotropic", "moment", NULL };

static void pbwgen__point(int kind, int dim, size_t i, size_t count, uint64_t *state, double *p)
{
    double t = ((double)i + 0.5) / (double)count, length = 2, turn = 6.283185307179586;
    uint64_t few = i % 32, many = i % (1 + (size_t)sqrt((double)count));
    size_t side = (size_t)ceil(pow((double)count, 1.0 / dim) - 1e-9), rest = i;
    int k;
    for (k = 0; k < dim; k++) {
        p[k] = kind == 1 || kind == 5 ? pbwgen__gauss(state) : pbwgen__uniform(state);
    }
    if (kind == 2 || kind == 3) {                    /* ball, sphere */
        while (!(length <= 1 && length > 1e-6)) {
            for (k = 0, length = 0; k < dim; k++) {
                p[k] = 2 * pbwgen__uniform(state) - 1;
                length += p[k] * p[k];
            }
        }
        for (k = 0; k < dim; k++) {
            p[k] /= kind == 3 ? sqrt(length) : 1;
        }
    } else if (kind == 4) {                          /* lattice */
        for (k = 0; k < dim; k++, rest /= side) {
            p[k] = (double)(rest % side);
        }
    } else if (kind == 5) {                          /* 32 clusters, from wide to narrow */
        for (k = 0; k < dim; k++) {
            p[k] = pbwgen__mixed(1 + 3 * few + (uint64_t)k) + p[k] * 0.1 / (double)(1 + few * few);
        }
    } else if (kind == 6) {                          /* as many lines, along the axes, as points on each */
        for (k = 0; k < dim; k++) {
            p[k] = (uint64_t)k == many % (uint64_t)dim ? p[k] : pbwgen__mixed(1 + 3 * many + (uint64_t)k);
        }
    } else if (kind == 7) {                          /* a sunflower; in 3D bent to a bowl */
        p[dim - 1] = t;
        p[0] = sqrt(t) * cos(turn * 0.3819660112501051 * (double)i);
        p[1] = sqrt(t) * sin(turn * 0.3819660112501051 * (double)i);
    } else if (kind == 8 || kind == 9) {             /* plane, anisotropic */
        p[dim - 1] *= kind == 8 ? 1e-9 : 1e-3;
        p[0] *= kind == 9 ? 1e3 : 1;
    } else if (kind == 10) {                         /* moment curve: in 3D every two points share a simplex */
        for (k = 0; k < dim; k++) {
            p[k] = pow(t, k + 1);
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>cloud        The points of a cloud.
   In: kind, dimension, count, seed.  Out: a cloud, or a status and an empty cloud.
   ------------------------------------------------------------------------------------------------------ */

/* Makes points of a kind, 0 to 10: its number in pbwgen_kinds; dim: 2 or 3.  options: memory_limit, resize, progress;
   NULL = defaults.  Returns PBW_OK, PBW_ERROR_ARGUMENT, PBW_ERROR_MEMORY or PBW_CANCELLED; pbwio_free when done. */
static pbw_status pbwgen_points(int kind, int dim, size_t count, uint64_t seed, const pbw_options *options,
                                pbwio_cloud *cloud)
{
    uint64_t state = seed << 40;
    size_t i;
    memset(cloud, 0, sizeof *cloud);
    if (kind < 0 || kind > 10 || dim < 2 || dim > 3) {
        return PBW_ERROR_ARGUMENT;
    }
    pbw_memory_start(&cloud->memory, options);
    if (count >= (size_t)-1 / 32 || !pbw_memory_fit(&cloud->memory, &cloud->points, &cloud->capacity[0],
                                                    (count * (size_t)dim + 1) * sizeof(double), 1)) {
        return PBW_ERROR_MEMORY;
    }
    cloud->dim = dim;
    cloud->count = count;
    for (i = 0; i < count; i++) {
        if (i % 16384 == 0 && options != NULL && options->progress != NULL
            && options->progress(options->progress_user, PBW_STAGE_WORK, (double)i / (double)count) != 0) {
            pbwio_free(cloud);
            return PBW_CANCELLED;
        }
        pbwgen__point(kind, dim, i, count, &state, cloud->points + i * (size_t)dim);
    }
    return PBW_OK;
}

#endif
