/* pbw_adapt3.h - v0.2.0 - tetrahedral meshes adapted to an error: sizes, and fields on the new mesh - MIT-0

   QUICK START
   In one source file, define PBW_ADAPT3_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file, and the implementations of pbw_surface.h and
   pbw_improve.h in the same source file, before it.

       pbw_improve_options how = {0};                                          // mesh: of pbw_solid or pbw_improve
       pbw_tets next = {0};
       double *sizes = (double *)malloc(mesh.point_count * sizeof *sizes);
       pbw_tets_sizes(&mesh, error, 2 * mesh.tet_count, sizes);                // error: one number a tetrahedron
       how.sizes = sizes;
       pbw_improve(&mesh, &how, NULL, &next, NULL);                            // finer where the error is
       pbw_tets_transfer(&mesh, &next, values, 1, NULL, new_values);           // one number a point

   CONTENTS  (search for the marks)
     >>interface    functions
     >>sizes        sizes from errors
     >>transfer     values carried over to another mesh

   FUNCTIONS
     pbw_tets_sizes     sizes at points, of errors of tetrahedra
     pbw_tets_transfer  values at the points of another mesh

   HOW
   A linear element of size h has an error of C h^(5/2) in the energy norm; sizes make it equal for all tetrahedra.
   pbw_improve halves and contracts edges until they fit.  Fields are linear in each old tetrahedron; a walk finds the
   one of each new point, and these follow a Hilbert curve.

   PROMISES  (tests/test_improve.c guards them)
     linear      linear fields are carried over up to rounding, and values never leave the range of the old ones
     whole       points outside of the old mesh get the value at the nearest place of its boundary

   CONFIGURATION MACROS
     PBW_ADAPT3_IMPLEMENTATION    in one source file: compile the implementation there
*/
#ifndef PBW_ADAPT3_H
#define PBW_ADAPT3_H
#ifndef PBW_IMPROVE_H
#include "pbw_improve.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Functions.
   ------------------------------------------------------------------------------------------------------ */
/* Fills sizes, one a point: edge lengths for a mesh of about `count` tetrahedra with equal errors, between an eighth
   of the old lengths and four times these.  error: per tetrahedron, in the energy norm over it, not squared. */
PBWDEF void pbw_tets_sizes(const pbw_tets *mesh, const double *error, size_t count, double *sizes);

/* Computes values at the points of another mesh of the domain.  from: a mesh with neighbors, as pbw_improve and
   pbw_solid make it; width: numbers a point; values: from->point_count * width, out: room for to->point_count *
   width.  Of options, it uses threads, resize and memory_limit.  Returns PBW_ERROR_ARGUMENT if `from` has no
   tetrahedra or no neighbors, or what pbw_order and pbw_surface_create fail with. */
PBWDEF pbw_status pbw_tets_transfer(const pbw_tets *from, const pbw_tets *to, const double *values,
                                    size_t width, const pbw_options *options, double *out);

#ifdef __cplusplus
}
#endif
#endif /* PBW_ADAPT3_H */

#if defined(PBW_ADAPT3_IMPLEMENTATION) && !defined(PBWADAPT3__IMPLEMENTED)
#define PBWADAPT3__IMPLEMENTED
#if PBWSF__SEAM != 1
#error "pbw_adapt3.h is compiled where pbw_surface.h of its version is: define PBW_SURFACE_IMPLEMENTATION, too"
#elif PBWIM__SEAM != 1
#error "pbw_adapt3.h is compiled where pbw_improve.h of its version is: define PBW_IMPROVE_IMPLEMENTATION, too"
#else

#include <math.h>
#include <string.h>

PBW_CONTRACTION_OFF                        /* fused operations would give other coordinates */

/* ------------------------------------------------------------------------------------------------------
   >>sizes        Sizes from errors.
   In: a mesh, errors of its tetrahedra.  Out: sizes at its points.
   ------------------------------------------------------------------------------------------------------ */
static void pbwa3__corners(const pbw_tets *mesh, size_t t, const double *c[4])
{
    int k;
    for (k = 0; k < 4; k++) {
        c[k] = mesh->points + 3 * (size_t)mesh->corners[4 * t + (size_t)k];
    }
}

/* Returns the mean length of the edges. */
static double pbwa3__length(const pbw_tets *mesh, size_t t)
{
    const double *c[4];
    double sum = 0;
    int e;
    pbwa3__corners(mesh, t, c);
    for (e = 0; e < 6; e++) {
        sum += pbwsf__distance(c[pbwim__edge[e][0]], c[pbwim__edge[e][1]]) / 6;
    }
    return sum;
}

PBWDEF void pbw_tets_sizes(const pbw_tets *mesh, const double *error, size_t count, double *sizes)
{
    double sum = 0, due, become = 0, scale;
    size_t t, k;
    for (t = 0; t < mesh->tet_count; t++) {          /* t becomes (error / due)^(6/5) tetrahedra */
        sum += pow(error[t], 1.2);
    }
    due = pow(sum / (double)(count > 0 ? count : 1), 1 / 1.2);
    for (k = 0; k < mesh->point_count; k++) {
        sizes[k] = HUGE_VAL;
    }
    for (t = 0; t < mesh->tet_count; t++) {
        const double factor = error[t] > 0 ? pow(due / error[t], 0.4) : 4;
        const double size = pbwa3__length(mesh, t) * fmin(fmax(factor, 0.125), 4);
        for (k = 0; k < 4; k++) {
            double *s = sizes + mesh->corners[4 * t + k];
            *s = fmin(*s, size);
        }
    }
    for (t = 0; t < mesh->tet_count; t++) {          /* the least at each point makes more than `count` */
        double mean = 0;
        for (k = 0; k < 4; k++) {
            mean += sizes[mesh->corners[4 * t + k]] / 4;
        }
        become += pow(pbwa3__length(mesh, t) / mean, 3);
    }
    scale = count > 0 ? cbrt(become / (double)count) : 1;
    for (k = 0; k < mesh->point_count; k++) {
        sizes[k] = sizes[k] < HUGE_VAL ? sizes[k] * scale : 1;                   /* points of no tetrahedron: any */
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>transfer     Values carried over to another mesh.
   In: a mesh with values at its points; other points.  Out: values at these.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwa3__places {
    const pbw_tets *from;
    pbw_surface surface;                   /* the boundary of `from` */
    PBW_ARRAY(pbw_index) facets, owners;   /* 3 points a facet of the boundary; its tetrahedron */
    PBW_ARRAY(pbw_index) order;            /* of the points of the other mesh */
} pbwa3__places;

/* Walks from t towards p.  Returns the tetrahedron where it ends; *inside: it contains p. */
static pbw_index pbwa3__walk(const pbw_tets *from, const double p[3], pbw_index t, int *inside)
{
    size_t steps, most = 1000 + from->tet_count / 4;
    for (*inside = 0, steps = 0; steps < most; steps++) {
        const double *c[4], *s[4];
        int i, beyond = 0;
        pbw_index next = PBW_NONE;
        pbwa3__corners(from, t, c);
        for (i = 0; i < 4 && next == PBW_NONE; i++) {
            const int k = (int)((steps + (size_t)i) % 4);        /* another first facet each step: no cycles */
            memcpy(s, c, sizeof s);
            s[k] = p;
            if (pbw_orient3(s[0], s[1], s[2], s[3]) < 0) {
                beyond = 1;
                next = from->neighbors[4 * (size_t)t + (size_t)k];
            }
        }
        if (next == PBW_NONE) {
            *inside = !beyond;
            return t;
        }
        t = next;
    }
    return t;
}

/* Returns the tetrahedron that contains p.  If there is none, moves p to the nearest place first. */
static pbw_index pbwa3__find(const pbwa3__places *places, double p[3], pbw_index hint)
{
    double nearby[3];
    int inside;
    pbw_index t = pbwa3__walk(places->from, p, hint, &inside), facet;
    if (inside) {
        return t;
    }
    facet = pbw_surface_closest(&places->surface, p, HUGE_VAL, nearby);
    if (facet == PBW_NONE) {
        return t;
    }
    hint = places->owners.at[facet];
    t = pbwa3__walk(places->from, p, hint, &inside);
    if (!inside) {
        memcpy(p, nearby, sizeof nearby);
        t = hint;
    }
    return t;
}

static void pbwa3__value(const pbw_tets *from, pbw_index t, const double p[3], const double *values, size_t width,
                         double *out)
{
    const double *c[4], *s[4];
    double weight[4], sum = 0;
    size_t j;
    int k;
    pbwa3__corners(from, t, c);
    for (k = 0; k < 4; k++) {
        memcpy(s, c, sizeof s);
        s[k] = p;
        weight[k] = fmax(pbw_tet_measure(PBW_MEASURE_VOLUME, s[0], s[1], s[2], s[3]), 0);
        sum += weight[k];
    }
    for (j = 0; j < width; j++) {
        out[j] = 0;
        for (k = 0; k < 4; k++) {
            const double *v = values + width * (size_t)from->corners[4 * (size_t)t + (size_t)k];
            out[j] += (sum > 0 ? weight[k] / sum : 0.25) * v[j];
        }
    }
}

/* Makes the boundary of `from` a surface. */
static pbw_status pbwa3__boundary(pbwa3__places *places, pbw_memory *memory, const pbw_options *options)
{
    const pbw_tets *from = places->from;
    pbw_options own = *options;
    pbw_status status;
    size_t i, k, count = 0;
    for (i = 0; i < 4 * from->tet_count; i++) {
        count += from->neighbors[i] == PBW_NONE;
    }
    if (!PBW_FIT(memory, places->facets, 3 * count + 1) || !PBW_FIT(memory, places->owners, count + 1)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = count = 0; i < 4 * from->tet_count; i++) {
        if (from->neighbors[i] == PBW_NONE) {
            for (k = 0; k < 3; k++) {
                places->facets.at[3 * count + k] = from->corners[i / 4 * 4 + (size_t)pbwim__opposite[i % 4][2 - k]];
            }
            places->owners.at[count++] = (pbw_index)(i / 4);
        }
    }
    own.memory_limit = pbw_memory_left(memory);
    status = pbw_surface_create(from->points, from->point_count, places->facets.at, count, &own, &places->surface);
    memory->used += pbwsf__bytes(&places->surface);
    return status;
}

PBWDEF pbw_status pbw_tets_transfer(const pbw_tets *from, const pbw_tets *to, const double *values,
                                    size_t width, const pbw_options *options, double *out)
{
    pbw_memory memory;
    pbwa3__places places;
    pbw_options plain;
    pbw_status status;
    pbw_index t = 0;
    size_t i;
    memset(&places, 0, sizeof places);
    if (from == NULL || to == NULL || values == NULL || out == NULL || from->tet_count == 0
        || from->neighbors == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    pbw_memory_start(&memory, options);
    memset(&plain, 0, sizeof plain);
    if (options != NULL) {                           /* not stride, weights or flags */
        plain.threads = options->threads;
        plain.resize = options->resize;
        plain.resize_user = options->resize_user;
    }
    places.from = from;
    status = pbwa3__boundary(&places, &memory, &plain);
    if (status == PBW_OK && !PBW_FIT(&memory, places.order, to->point_count + 1)) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        plain.memory_limit = pbw_memory_left(&memory);
        status = pbw_order(3, to->points, to->point_count, &plain, places.order.at);
    }
    for (i = 0; i < to->point_count && status == PBW_OK; i++) {
        const size_t p = places.order.at[i];
        double place[3];
        memcpy(place, to->points + 3 * p, sizeof place);
        t = pbwa3__find(&places, place, t);
        pbwa3__value(from, t, place, values, width, out + width * p);
    }
    pbw_surface_free(&places.surface);
    PBW_RELEASE(&memory, places.facets);
    PBW_RELEASE(&memory, places.owners);
    PBW_RELEASE(&memory, places.order);
    return status;
}

PBW_CONTRACTION_ON
#endif /* PBWSF__SEAM, PBWIM__SEAM */
#endif /* PBW_ADAPT3_IMPLEMENTATION */
