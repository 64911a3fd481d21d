/* pbw_sample.h - v0.2.0 - points on and in triangulated surfaces - MIT-0

   QUICK START
   In one source file, define PBW_SAMPLE_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file.

       pbwsample_model model = {0};
       pbwsample_options options = {0};
       pbwsample_set set = {0};
       pbw_mesh mesh = {0};
       model.points = points;        model.point_count = n;                 // of any model, such as a pbwio_cloud
       model.triangles = triangles;  model.triangle_count = m;
       options.count = 20000;
       pbwsample_poisson(&model, &options, &set);                           // on the surface
       options.count = 0;
       pbwsample_volume(&model, &options, &set);                            // and inside, as dense
       pbw_triangulate(3, set.points, NULL, set.count, NULL, &mesh);
       pbwsample_free(&set);

   FUNCTIONS
     pbwsample_uniform        independent points on a surface
     pbwsample_poisson        points on a surface, evenly apart
     pbwsample_volume         points inside
     pbwsample_inside         which points are inside of a surface
     pbwsample_inspect        whether a surface is closed, its area and volume
     pbwsample_free           frees a set
     pbwsample_status_string  a status in words

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>tools        arrays, progress, a hash table
     >>surface      areas, edges, normals
     >>uniform      independent samples
     >>inside       rays through a surface
     >>balls        Poisson sets: samples and their balls
     >>pieces       Poisson sets: triangles and boxes
     >>darts        Poisson sets: a dart at a piece
     >>sets         Poisson sets: rounds; the radius for a count

   WHAT                      how                                                       promise
     pbwsample_uniform       independent, as dense as options.size asks                the same for any number of
                                                                                       threads
     pbwsample_poisson       blue noise: no two closer than a radius                   maximal (by radius), or the
                                                                                       exact count
     pbwsample_volume        the same inside a closed surface, away from what the      same
                             set holds already; or a jittered lattice
     pbwsample_inspect       open edges, wrong turns, ... of a surface by number
     pbwsample_inside        which points are inside

   PROMISES  (tests/test_sample.c guards them)
     same        a set is a function of the model and of the options: random numbers are a function of the seed and of
                 a counter (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3")
     apart       a sample of a Poisson set lies in no ball of an earlier one, with radius times options.size there
     maximal     sets by radius: every point of the surface lies in the ball of a sample, up to one part in 2^20 of
                 the radius; every point inside a volume within 1.25 radii of one
     exact       as many as options.count asks for
     any model   facets without area, unused points, open and crowded edges, triangle soup: they are handled if that
                 makes sense, otherwise a status names them
     quiet       no globals, nothing printed, no exit
     bounded     memory_limit holds in every call.  Memory: about 75 bytes a triangle, 110 for a volume, 260 if its
                 surface is open; and for each sample 65 if uniform or in a lattice, 470 in a Poisson set of a
                 surface, 2400 of a volume

   CONFIGURATION MACROS
     PBW_SAMPLE_IMPLEMENTATION   in one source file: compile the implementation there
*/
#ifndef PBW_SAMPLE_H
#define PBW_SAMPLE_H
/* ------------------------------------------------------------------------------------------------------
   >>interface    types and functions
   ------------------------------------------------------------------------------------------------------ */
#ifndef PBW_H
#include "pbw.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pbwsample_model {       /* a surface; the arrays are the caller's */
    size_t point_count, triangle_count, normal_count;
    const double *points;              /* 3 coordinates each */
    const pbw_index *triangles;        /* 3 ids of points each */
    const double *normals;             /* 3 coordinates each, of any length; NULL = they are computed */
    const pbw_index *normal_ids;       /* 3 ids of normals for each triangle; NULL = those of its points */
} pbwsample_model;

#define PBWSAMPLE_NORMALS       1u     /* fill set.normals */
#define PBWSAMPLE_FACET_NORMALS 2u     /* with those of the facets, not with interpolated ones */
#define PBWSAMPLE_THIN          4u     /* Poisson: samples whose facets look away from each other may be close */
#define PBWSAMPLE_LATTICE       8u     /* volume: a body-centred lattice instead of blue noise */

typedef struct pbwsample_options {     /* all zero = best defaults, but for count and radius */
    uint64_t seed;
    size_t count;                      /* exactly so many samples, or 0: as many as there is room for with */
    double radius;                     /* this distance between samples; 0 for a volume: that of the set */
    double (*size)(void *user, const double point[3]);     /* the radius there is this times as large; NULL = 1 */
    unsigned flags;
    double jitter;                     /* lattice: how far points may move, in cells; 0 = 0.1, < 0: none */
    void *size_user;
    const pbw_options *build;          /* memory_limit, resize, progress; threads and run of pbwsample_uniform; as in
                                          pbw.h, NULL = defaults */
} pbwsample_options;

typedef struct pbwsample_set {         /* start from {0}; pbwsample_free when done */
    size_t count;
    double radius;                     /* Poisson: the distance kept; 0 = none is */
    double *points;                    /* 3 coordinates each */
    double *normals;                   /* 3 each, of length 1, zero inside; NULL without PBWSAMPLE_NORMALS */
    pbw_index *triangles;              /* which one each lies on, PBW_NONE inside */
    double *places;                    /* 2 each: a point is (1 - u - v) a + u b + v c; zero inside */
    pbw_memory memory;                 /* private: of these arrays, and their capacities */
    size_t capacity[4];
} pbwsample_set;

typedef struct pbwsample_report {      /* edges are counted with points at one place taken for one */
    size_t duplicate_points, unused_points, flat_triangles;     /* flat: no area */
    size_t open_edges, crowded_edges, turned_edges;     /* of 1 triangle, more than 2, 2 that run along it alike */
    int closed;                        /* none of those edges: there is an inside */
    double area, volume;               /* volume: less than zero if the facets look inwards */
} pbwsample_report;

/* All of them return PBW_OK, or
   PBW_DEGENERATE         no triangle has an area; or nothing is inside, or so little that no sample hits it
   PBW_CANCELLED          the progress callback said stop
   PBW_ERROR_ARGUMENT     NULL, an id out of range, not one of count and radius, a size that is not above 0
   PBW_ERROR_NOT_FINITE   a coordinate is not finite, or so large that areas are not
   PBW_ERROR_TOO_LARGE    more samples than an index can number
   PBW_ERROR_MEMORY       out of memory, or over memory_limit
   or what pbw_for returns. */

/* Fill an empty set; on failure it is left empty.  Samples keep to the surface within rounding. */
PBWDEF pbw_status pbwsample_uniform(const pbwsample_model *model, const pbwsample_options *options,
                                    pbwsample_set *set);
PBWDEF pbw_status pbwsample_poisson(const pbwsample_model *model, const pbwsample_options *options,
                                    pbwsample_set *set);
/* Adds points inside to a set, which on failure is as before.  The set keeps the allocator that it was first filled
   with, and counts against memory_limit. */
PBWDEF pbw_status pbwsample_volume(const pbwsample_model *model, const pbwsample_options *options,
                                   pbwsample_set *set);
/* inside[i] = 1 if point i is: a ray leaves the surface an odd number of times.  Exact for a closed surface; of an
   open one, two of three rays along the axes must say so.  A point on the surface may count as either.
   options: threads, run, memory_limit, resize, progress; NULL = defaults. */
PBWDEF pbw_status pbwsample_inside(const pbwsample_model *model, const double *points, size_t count,
                                   const pbw_options *options, unsigned char *inside);
/* options: memory_limit, resize, progress; NULL = defaults. */
PBWDEF pbw_status pbwsample_inspect(const pbwsample_model *model, const pbw_options *options,
                                    pbwsample_report *report);
/* Frees what a set holds and zeroes it; fine on {0}, fine twice. */
PBWDEF void pbwsample_free(pbwsample_set *set);
/* What a status of these functions means.  Never NULL, never freed. */
PBWDEF const char *pbwsample_status_string(pbw_status status);

#ifdef __cplusplus
}
#endif
#endif /* PBW_SAMPLE_H */

#if defined(PBW_SAMPLE_IMPLEMENTATION) && !defined(PBWSAMPLE__IMPLEMENTED)
#define PBWSAMPLE__IMPLEMENTED

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

PBW_CONTRACTION_OFF

/* ------------------------------------------------------------------------------------------------------
   >>tools        Arrays, progress, a hash table.
   In: keys of 64 bits.  Out: the value of a key, a new one if there is none.
   Holds: a table is at most half full.
   ------------------------------------------------------------------------------------------------------ */

typedef PBW_ARRAY(double) pbwsample__doubles;
typedef PBW_ARRAY(pbw_index) pbwsample__ids;

static double pbwsample__low_half(uint64_t bits)                     /* inside (0, 1) */
{
    return ((double)(bits & 0xffffffffu) + 0.5) / 4294967296.0;
}

/* Reports progress every 1024 items.  Returns whether the callback ends the call. */
static int pbwsample__stops(const pbw_options *build, size_t i, double done)
{
    return i % 1024 == 0 && build != NULL && build->progress != NULL
        && build->progress(build->progress_user, PBW_STAGE_WORK, done) != 0;
}

#define PBWSAMPLE__NO_KEY ((uint64_t)-1)

typedef struct pbwsample__slot { uint64_t key; pbw_index value; } pbwsample__slot;
typedef struct pbwsample__table { pbwsample__slot *slots; size_t used; int bits; } pbwsample__table;

/* The slot that has the key, or the free one for it; linear probing. */
static pbwsample__slot *pbwsample__slot_of(const pbwsample__table *table, uint64_t key)
{
    size_t mask = ((size_t)1 << table->bits) - 1, at = (size_t)((key ^ key >> 29) * 0x9e3779b97f4a7c15u >> 32) & mask;
    while (table->slots[at].key != key && table->slots[at].key != PBWSAMPLE__NO_KEY) {
        at = (at + 1) & mask;
    }
    return table->slots + at;
}

static void pbwsample__free_table(pbw_memory *memory, pbwsample__table *table)
{
    if (table->slots != NULL) {
        (void)pbw_memory_resize(memory, table->slots, (size_t)1 << table->bits, 0, sizeof *table->slots);
    }
    memset(table, 0, sizeof *table);
}

/* The value of the key, PBW_NONE if it is new; NULL = out of memory. */
static pbw_index *pbwsample__enter(pbw_memory *memory, pbwsample__table *table, uint64_t key)
{
    const size_t old = table->slots == NULL ? 0 : (size_t)1 << table->bits;
    pbwsample__slot *slot;
    if (2 * table->used >= old) {
        pbwsample__table larger = *table;
        size_t i, count = (size_t)1 << (larger.bits = old == 0 ? 10 : table->bits + 1);
        larger.slots = (pbwsample__slot *)pbw_memory_resize(memory, NULL, 0, count, sizeof *larger.slots);
        if (larger.slots == NULL) {
            return NULL;
        }
        memset(larger.slots, 0xff, count * sizeof *larger.slots);    /* PBWSAMPLE__NO_KEY, PBW_NONE */
        for (i = 0; i < old; i++) {
            if (table->slots[i].key != PBWSAMPLE__NO_KEY) {
                *pbwsample__slot_of(&larger, table->slots[i].key) = table->slots[i];
            }
        }
        pbwsample__free_table(memory, table);
        *table = larger;
    }
    slot = pbwsample__slot_of(table, key);
    if (slot->key != key) {
        slot->key = key;
        table->used++;
    }
    return &slot->value;
}

/* ------------------------------------------------------------------------------------------------------
   >>surface      Areas, edges and normals of a surface.
   In: a model.  Out: its report; normals of points; room for samples, and their normals.
   Holds: points at one place count as the first of them.
   ------------------------------------------------------------------------------------------------------ */

static double pbwsample__dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double pbwsample__square(const double a[3], const double b[3])
{
    double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
}

static const double *pbwsample__corner(const pbwsample_model *model, size_t triangle, size_t corner)
{
    return model->points + 3 * (size_t)model->triangles[3 * triangle + corner];
}

/* The normal of a facet, as long as twice its area. */
static void pbwsample__facet_normal(const pbwsample_model *model, size_t triangle, double n[3])
{
    const double *a = pbwsample__corner(model, triangle, 0), *b = pbwsample__corner(model, triangle, 1);
    const double *c = pbwsample__corner(model, triangle, 2);
    int i;
    for (i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]);
    }
}

static double pbwsample__area(const pbwsample_model *model, size_t triangle)
{
    double n[3];
    pbwsample__facet_normal(model, triangle, n);
    return 0.5 * sqrt(pbwsample__dot(n, n));
}

/* The volume within, positive if the facets look outwards; measured from the first corner, for accuracy. */
static double pbwsample__volume_of(const pbwsample_model *model)
{
    double sum = 0, n[3], from[3];
    size_t i;
    int k;
    for (i = 0; i < model->triangle_count; i++) {
        pbwsample__facet_normal(model, i, n);
        for (k = 0; k < 3; k++) {
            from[k] = pbwsample__corner(model, i, 0)[k] - pbwsample__corner(model, 0, 0)[k];
        }
        sum += pbwsample__dot(from, n) / 6;
    }
    return sum;
}

static pbw_status pbwsample__check_model(const pbwsample_model *model)
{
    size_t i;
    double total = 0;
    if (model == NULL || model->points == NULL || model->triangles == NULL || model->point_count >= PBW_NONE
        || model->triangle_count >= PBW_NONE / 3) {
        return PBW_ERROR_ARGUMENT;
    }
    for (i = 0; i < 3 * model->triangle_count; i++) {
        if (model->triangles[i] >= model->point_count
            || (model->normals != NULL && (model->normal_ids != NULL ? model->normal_ids[i] : model->triangles[i])
                                          >= model->normal_count)) {
            return PBW_ERROR_ARGUMENT;
        }
    }
    for (i = 0; i < model->triangle_count; i++) {
        total += pbwsample__area(model, i);
    }
    return !(total <= DBL_MAX) ? PBW_ERROR_NOT_FINITE : total > 0 ? PBW_OK : PBW_DEGENERATE;
}

/* For each point the first one at its place.  Returns 0 = out of memory. */
static int pbwsample__weld(pbw_memory *memory, const pbwsample_model *model, pbwsample__ids *first)
{
    pbwsample__table table = { NULL, 0, 0 };
    pbw_index *value;
    size_t i;
    int k, done = PBW_ZEROS(memory, *first, model->point_count);
    for (i = 0; i < model->point_count && done; i++) {
        const double *p = model->points + 3 * i;
        uint64_t key = 1;
        for (k = 0; k < 3; k++) {
            double x = p[k] + 0.0;                                   /* -0.0 becomes 0.0 */
            uint64_t bits;
            memcpy(&bits, &x, sizeof bits);
            key = pbw_random(key, bits);
        }
        do {
            key = pbw_random(key, 0) >> 1;                           /* another one, if its place was another */
            value = pbwsample__enter(memory, &table, key);
        } while (value != NULL && *value != PBW_NONE && pbwsample__square(p, model->points + 3 * (size_t)*value) > 0);
        done = value != NULL;
        if (done) {
            *value = *value == PBW_NONE ? (pbw_index)i : *value;
            first->at[i] = *value;
        }
    }
    pbwsample__free_table(memory, &table);
    return done;
}

/* Counts how often triangles run along each edge, into a table: there, and 65536 times back, each 3 at most.  Fills
   in what the report says of triangles and points.  share: of the progress. */
static pbw_status pbwsample__count_edges(pbw_memory *memory, const pbwsample_model *model, const pbw_options *options,
                                         double share, pbwsample__table *edges, pbwsample_report *report)
{
    pbwsample__ids first = { NULL, 0, 0 };
    PBW_ARRAY(unsigned char) used = { NULL, 0, 0 };
    pbw_status status = pbwsample__weld(memory, model, &first) && PBW_ZEROS(memory, used, model->point_count)
                      ? PBW_OK : PBW_ERROR_MEMORY;
    size_t i, k;
    for (i = 0; i < model->triangle_count && status == PBW_OK; i++) {
        const pbw_index *t = model->triangles + 3 * i;
        double area = pbwsample__area(model, i);
        report->area += area;
        report->flat_triangles += !(area > 0);
        for (k = 0; k < 3 && status == PBW_OK; k++) {
            pbw_index a = first.at[t[k]], b = first.at[t[(k + 1) % 3]], *value;
            used.at[t[k]] = 1;
            if (a != b) {
                value = pbwsample__enter(memory, edges, a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a);
                if (value == NULL) {
                    status = PBW_ERROR_MEMORY;
                } else {
                    unsigned shift = a < b ? 0 : 16;
                    *value = *value == PBW_NONE ? 0 : *value;
                    *value += (*value >> shift & 0xffff) < 3 ? 1u << shift : 0;
                }
            }
        }
        if (pbwsample__stops(options, i, share * (double)i / (double)model->triangle_count)) {
            status = PBW_CANCELLED;
        }
    }
    for (i = 0; i < model->point_count && status == PBW_OK; i++) {
        report->duplicate_points += first.at[i] != i;
        report->unused_points += !used.at[i];
    }
    PBW_RELEASE(memory, first);
    PBW_RELEASE(memory, used);
    return status;
}

static pbw_status pbwsample__inspect(pbw_memory *memory, const pbwsample_model *model, const pbw_options *options,
                                     double share, pbwsample_report *report)
{
    pbwsample__table edges = { NULL, 0, 0 };
    pbw_status status;
    size_t i, slots;
    memset(report, 0, sizeof *report);
    status = pbwsample__count_edges(memory, model, options, share, &edges, report);
    slots = edges.slots != NULL ? (size_t)1 << edges.bits : 0;
    for (i = 0; i < slots && status == PBW_OK; i++) {
        if (edges.slots[i].key != PBWSAMPLE__NO_KEY) {
            unsigned there = edges.slots[i].value & 0xffff, back = edges.slots[i].value >> 16;
            report->open_edges += there + back == 1;
            report->crowded_edges += there + back > 2;
            report->turned_edges += there + back == 2 && there != back;
        }
    }
    if (status == PBW_OK) {
        report->volume = pbwsample__volume_of(model);
        report->closed = report->open_edges + report->crowded_edges + report->turned_edges == 0;
    }
    pbwsample__free_table(memory, &edges);
    return status;
}

PBWDEF pbw_status pbwsample_inspect(const pbwsample_model *model, const pbw_options *options,
                                    pbwsample_report *report)
{
    pbw_memory memory;
    pbw_status status = pbwsample__check_model(model);
    pbw_memory_start(&memory, options);
    return status != PBW_OK ? status : report == NULL ? PBW_ERROR_ARGUMENT
         : pbwsample__inspect(&memory, model, options, 1, report);
}

/* Normals of the points: of the facets around, weighted with their angles there (Thuermer and Wuethrich 1998,
   "Computing vertex normals from polygonal facets").  Returns 0 = out of memory. */
static int pbwsample__point_normals(pbw_memory *memory, const pbwsample_model *model, pbwsample__doubles *normals)
{
    pbwsample__ids first = { NULL, 0, 0 };
    const int done = pbwsample__weld(memory, model, &first) && PBW_ZEROS(memory, *normals, 3 * model->point_count);
    double n[3], p[3], q[3], length, angle;
    size_t i, j, k;
    for (i = 0; i < model->triangle_count && done; i++) {
        pbwsample__facet_normal(model, i, n);
        length = sqrt(pbwsample__dot(n, n));
        for (j = 0; j < 3 && length > 0; j++) {
            for (k = 0; k < 3; k++) {
                p[k] = pbwsample__corner(model, i, (j + 1) % 3)[k] - pbwsample__corner(model, i, j)[k];
                q[k] = pbwsample__corner(model, i, (j + 2) % 3)[k] - pbwsample__corner(model, i, j)[k];
            }
            angle = atan2(length, pbwsample__dot(p, q));
            for (k = 0; k < 3; k++) {
                normals->at[3 * (size_t)first.at[model->triangles[3 * i + j]] + k] += angle * n[k] / length;
            }
        }
    }
    for (i = done ? model->point_count : 0; i-- > 0;) {              /* first[i] <= i: it is still whole */
        if (first.at[i] != i) {
            memcpy(normals->at + 3 * i, normals->at + 3 * (size_t)first.at[i], 3 * sizeof(double));
        }
    }
    PBW_RELEASE(memory, first);
    return done;
}

/* The normals of samples begin to end - 1, from those of the model's points; normals NULL: those of the facets. */
static void pbwsample__set_normals(const pbwsample_model *model, const double *normals, const pbw_index *ids,
                                   pbwsample_set *set, size_t begin, size_t end)
{
    size_t i, j, k;
    for (i = begin; i < end; i++) {
        size_t t = set->triangles[i];
        double *n = set->normals + 3 * i, u = set->places[2 * i], v = set->places[2 * i + 1], weight[3], length = 0;
        n[0] = n[1] = n[2] = 0;
        if (t == PBW_NONE) {
            continue;
        }
        weight[0] = 1 - u - v;
        weight[1] = u;
        weight[2] = v;
        for (j = 0; j < 3 && normals != NULL; j++) {
            const double *corner = normals + 3 * (size_t)ids[3 * t + j];
            length = sqrt(pbwsample__dot(corner, corner));
            for (k = 0; k < 3; k++) {
                n[k] += length > 0 ? weight[j] * corner[k] / length : 0;
            }
        }
        length = sqrt(pbwsample__dot(n, n));
        if (!(length > 1e-6 && length <= DBL_MAX)) {                 /* none given, or they cancel */
            pbwsample__facet_normal(model, t, n);
            length = sqrt(pbwsample__dot(n, n));
        }
        for (k = 0; k < 3; k++) {
            n[k] /= length;
        }
    }
}

/* Makes room for more samples behind the last.  Returns whether there is. */
static int pbwsample__reserve(pbwsample_set *set, size_t more, unsigned flags)
{
    pbw_memory *memory = &set->memory;
    size_t *capacity = set->capacity;
    return pbw_memory_grow(memory, &set->points, capacity, set->count, more, 3 * sizeof(double))
        && pbw_memory_grow(memory, &set->places, capacity + 1, set->count, more, 2 * sizeof(double))
        && pbw_memory_grow(memory, &set->triangles, capacity + 2, set->count, more, sizeof(pbw_index))
        && (!(flags & PBWSAMPLE_NORMALS)
            || pbw_memory_grow(memory, &set->normals, capacity + 3, set->count, more, 3 * sizeof(double)));
}

PBWDEF void pbwsample_free(pbwsample_set *set)
{
    if (set != NULL) {
        (void)pbw_memory_fit(&set->memory, &set->points, set->capacity, 0, 3 * sizeof(double));
        (void)pbw_memory_fit(&set->memory, &set->places, set->capacity + 1, 0, 2 * sizeof(double));
        (void)pbw_memory_fit(&set->memory, &set->triangles, set->capacity + 2, 0, sizeof(pbw_index));
        (void)pbw_memory_fit(&set->memory, &set->normals, set->capacity + 3, 0, 3 * sizeof(double));
        memset(set, 0, sizeof *set);
    }
}

PBWDEF const char *pbwsample_status_string(pbw_status status)
{
    return status == PBW_DEGENERATE ? "the surface has no area, or encloses nothing, or too little to be hit"
         : status == PBW_ERROR_ARGUMENT
         ? "an argument is wrong: NULL, an id out of range, no count or radius, a size of 0"
         : status == PBW_ERROR_NOT_FINITE ? "a coordinate is not finite, or so large that areas are not"
         : status == PBW_ERROR_TOO_LARGE ? "more samples than an index can number" : pbw_status_string(status);
}

/* ------------------------------------------------------------------------------------------------------
   >>uniform      Uniform samples.
   In: a model, sizes.  Out: as many independent samples as are asked for.
   Holds: sample i is a function of the seed and of i: which task makes it does not matter.

   1. The weight of a triangle is its area over the square of the size in its middle.
   2. A random number is looked up in the running sum of the weights, through a table of as many equal steps as there
      are triangles (Chen and Asau 1974, "On generating random variates from an empirical distribution").
   3. A point of the unit square, folded to a triangle, is the place in it.
   ------------------------------------------------------------------------------------------------------ */
#define PBWSAMPLE__BLOCK 65536

typedef struct pbwsample__uniform_work {
    const pbwsample_model *model;
    pbwsample_set *set;
    uint64_t key;
    unsigned flags;
    const double *normals;
    const pbw_index *ids;
    pbwsample__doubles sums;                   /* the weight of each triangle and of all before */
    pbwsample__ids guide;                      /* the first triangle of each step */
} pbwsample__uniform_work;

static pbw_status pbwsample__uniform_range(void *arg, size_t begin, size_t end)
{
    const pbwsample__uniform_work *w = (const pbwsample__uniform_work *)arg;
    size_t triangles = w->model->triangle_count, i, k;
    for (i = begin; i < end; i++) {
        uint64_t bits = pbw_random(w->key, 2 * i + 1);
        double at = (double)(pbw_random(w->key, 2 * i) >> 11) / 9007199254740992.0;
        double u = pbwsample__low_half(bits), v = pbwsample__low_half(bits >> 32);
        size_t t = w->guide.at[(size_t)(at * (double)triangles)];
        const double *a, *b, *c;
        while (w->sums.at[t] <= at * w->sums.at[triangles - 1]) {
            t++;
        }
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        a = pbwsample__corner(w->model, t, 0);
        b = pbwsample__corner(w->model, t, 1);
        c = pbwsample__corner(w->model, t, 2);
        for (k = 0; k < 3; k++) {
            w->set->points[3 * i + k] = a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]);
        }
        w->set->triangles[i] = (pbw_index)t;
        w->set->places[2 * i] = u;
        w->set->places[2 * i + 1] = v;
    }
    if (w->flags & PBWSAMPLE_NORMALS) {
        pbwsample__set_normals(w->model, w->flags & PBWSAMPLE_FACET_NORMALS ? NULL : w->normals, w->ids,
                               w->set, begin, end);
    }
    return PBW_OK;
}

/* The size that the callback gives for the middle of a triangle; 0 if it is not proper. */
static double pbwsample__size_at(const pbwsample_options *options, const double p[3])
{
    double size = options->size != NULL ? options->size(options->size_user, p) : 1;
    return size > 0 && size <= DBL_MAX ? size : 0;
}

/* The weights: areas over squared sizes. */
static pbw_status pbwsample__weigh(pbwsample__uniform_work *w, const pbwsample_options *options)
{
    size_t i, k, step = 0, triangles = w->model->triangle_count;
    double sum = 0, size, middle[3];
    for (i = 0; i < triangles; i++) {
        for (k = 0; k < 3; k++) {
            middle[k] = (pbwsample__corner(w->model, i, 0)[k] + pbwsample__corner(w->model, i, 1)[k]
                         + pbwsample__corner(w->model, i, 2)[k]) / 3;
        }
        size = pbwsample__size_at(options, middle);
        if (!(size > 0)) {
            return PBW_ERROR_ARGUMENT;
        }
        w->sums.at[i] = sum += pbwsample__area(w->model, i) / (size * size);
    }
    for (i = 0; i < triangles; i++) {
        while (step < triangles && w->sums.at[i] > sum * ((double)step / (double)triangles)) {
            w->guide.at[step++] = (pbw_index)i;
        }
    }
    return sum > 0 && sum <= DBL_MAX ? PBW_OK : PBW_ERROR_ARGUMENT;
}

PBWDEF pbw_status pbwsample_uniform(const pbwsample_model *model, const pbwsample_options *options,
                                    pbwsample_set *set)
{
    pbwsample__uniform_work w;
    pbwsample__doubles computed = { NULL, 0, 0 };
    pbw_options build;
    pbw_memory *memory;
    pbw_status status = pbwsample__check_model(model);
    if (set == NULL || options == NULL || options->count == 0 || status != PBW_OK) {
        return status != PBW_OK ? status : PBW_ERROR_ARGUMENT;
    }
    memset(set, 0, sizeof *set);
    if (options->count >= PBW_NONE) {
        return PBW_ERROR_TOO_LARGE;
    }
    memory = &set->memory;
    pbw_memory_start(memory, options->build);
    memset(&w, 0, sizeof w);
    w.model = model;
    w.set = set;
    w.key = pbw_random(0, options->seed);
    w.flags = options->flags;
    status = PBW_ZEROS(memory, w.sums, model->triangle_count) && PBW_ZEROS(memory, w.guide, model->triangle_count)
          && (!(options->flags & PBWSAMPLE_NORMALS) || model->normals != NULL
              || pbwsample__point_normals(memory, model, &computed))
          && pbwsample__reserve(set, options->count, options->flags) ? PBW_OK : PBW_ERROR_MEMORY;
    w.normals = model->normals != NULL ? model->normals : computed.at;
    w.ids = model->normals != NULL && model->normal_ids != NULL ? model->normal_ids : model->triangles;
    status = status != PBW_OK ? status : pbwsample__weigh(&w, options);
    if (status == PBW_OK) {
        memset(&build, 0, sizeof build);
        build = options->build != NULL ? *options->build : build;
        pbw_memory_nest(memory, &build);
        set->count = options->count;
        status = pbw_for(&build, set->count, PBWSAMPLE__BLOCK, pbwsample__uniform_range, &w);
    }
    PBW_RELEASE(memory, computed);
    PBW_RELEASE(memory, w.sums);
    PBW_RELEASE(memory, w.guide);
    if (status != PBW_OK) {
        pbwsample_free(set);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>inside       Which points are inside of a surface.
   In: a model, points.  Out: for each whether a ray from it along an axis crosses the surface an odd number of times.
   Holds: every sign is exact.  The point counts as moved by (e, e^2) within the plane across the ray, e
   infinitesimal, so that the ray meets no corner and no edge.
   ------------------------------------------------------------------------------------------------------ */

typedef struct pbwsample__box { double low[3], high[3]; } pbwsample__box;

typedef struct pbwsample__columns {            /* a grid across an axis; which triangles are over each cell */
    const pbwsample_model *model;
    int axis;
    size_t side;
    PBW_ARRAY(size_t) first;                   /* first[c] to first[c+1] in list are those over cell c */
    pbwsample__ids list;
    PBW_ARRAY(pbwsample__box) boxes;           /* around each triangle */
    double low[2], scale[2];
} pbwsample__columns;

static size_t pbwsample__column(const pbwsample__columns *grid, double x, int k)
{
    double at = (x - grid->low[k]) * grid->scale[k];
    return at > 0 ? at >= (double)grid->side ? grid->side - 1 : (size_t)at : 0;
}

static pbwsample__box pbwsample__box_of(const pbwsample_model *model, size_t triangle)
{
    const double *a = pbwsample__corner(model, triangle, 0), *b = pbwsample__corner(model, triangle, 1);
    const double *c = pbwsample__corner(model, triangle, 2);
    pbwsample__box box;
    int k;
    for (k = 0; k < 3; k++) {
        box.low[k] = a[k] < b[k] ? a[k] < c[k] ? a[k] : c[k] : b[k] < c[k] ? b[k] : c[k];
        box.high[k] = a[k] > b[k] ? a[k] > c[k] ? a[k] : c[k] : b[k] > c[k] ? b[k] : c[k];
    }
    return box;
}

/* Widens a box to have another in it. */
static void pbwsample__unite(pbwsample__box *box, const pbwsample__box *other)
{
    int k;
    for (k = 0; k < 3; k++) {
        box->low[k] = other->low[k] < box->low[k] ? other->low[k] : box->low[k];
        box->high[k] = other->high[k] > box->high[k] ? other->high[k] : box->high[k];
    }
}

static int pbwsample__make_columns(pbw_memory *memory, pbwsample__columns *grid, const pbwsample_model *model,
                                   int axis)
{
    size_t i, x, y, total = 0, range[2][2];
    pbwsample__box all = pbwsample__box_of(model, 0);
    int k, pass;
    memset(grid, 0, sizeof *grid);
    grid->model = model;
    grid->axis = axis;
    grid->side = (size_t)sqrt((double)model->triangle_count / 2) + 1;
    grid->side = grid->side < 1024 ? grid->side : 1024;
    if (!PBW_ZEROS(memory, grid->first, grid->side * grid->side + 1)
        || !PBW_FIT(memory, grid->boxes, model->triangle_count)) {
        return 0;
    }
    for (i = 0; i < model->triangle_count; i++) {
        grid->boxes.at[i] = pbwsample__box_of(model, i);
        pbwsample__unite(&all, grid->boxes.at + i);
    }
    for (k = 0; k < 2; k++) {
        int across = (axis + 1 + k) % 3;
        grid->low[k] = all.low[across];
        grid->scale[k] = all.high[across] > all.low[across]
                       ? (double)grid->side / (all.high[across] - all.low[across]) : 0;
    }
    for (pass = 0; pass < 2; pass++) {                               /* count, then fill from the back */
        for (i = 0; i < model->triangle_count; i++) {
            for (k = 0; k < 2; k++) {
                range[k][0] = pbwsample__column(grid, grid->boxes.at[i].low[(axis + 1 + k) % 3], k);
                range[k][1] = pbwsample__column(grid, grid->boxes.at[i].high[(axis + 1 + k) % 3], k);
            }
            for (y = range[1][0]; y <= range[1][1]; y++) {
                for (x = range[0][0]; x <= range[0][1]; x++) {
                    if (pass == 0) {
                        grid->first.at[y * grid->side + x]++;
                    } else {
                        grid->list.at[--grid->first.at[y * grid->side + x]] = (pbw_index)i;
                    }
                }
            }
        }
        for (i = 0; pass == 0 && i <= grid->side * grid->side; i++) {
            grid->first.at[i] = total += grid->first.at[i];
        }
        if (pass == 0) {
            if (!PBW_FIT(memory, grid->list, total)) {
                return 0;
            }
        }
    }
    return 1;
}

static void pbwsample__free_columns(pbw_memory *memory, pbwsample__columns *grid)
{
    PBW_RELEASE(memory, grid->first);
    PBW_RELEASE(memory, grid->list);
    PBW_RELEASE(memory, grid->boxes);
}

/* The side of the line from a to b that the moved point is on, in the plane of x and y; 0 only if a and b are at one
   place there.  The derivatives of orient2 by the move are a.y - b.y for e and b.x - a.x for e^2. */
static int pbwsample__side(const double a[2], const double b[2], const double p[2])
{
    int sign = pbw_orient2(a, b, p);
    return sign != 0 ? sign : a[1] > b[1] ? 1 : a[1] < b[1] ? -1 : (b[0] > a[0]) - (b[0] < a[0]);
}

/* Returns whether the ray upwards along the axis crosses the surface an odd number of times. */
static int pbwsample__crosses_odd(const pbwsample__columns *grid, const double p[3])
{
    int u = (grid->axis + 1) % 3, v = (grid->axis + 2) % 3, turn, odd = 0;
    size_t cell = pbwsample__column(grid, p[v], 1) * grid->side + pbwsample__column(grid, p[u], 0), i, j;
    double corner[3][2], q[2];
    q[0] = p[u];
    q[1] = p[v];
    for (i = grid->first.at[cell]; i < grid->first.at[cell + 1]; i++) {
        size_t t = grid->list.at[i];
        const pbwsample__box *box = grid->boxes.at + t;
        if (box->high[grid->axis] < p[grid->axis] || box->low[u] > p[u] || box->high[u] < p[u] || box->low[v] > p[v]
            || box->high[v] < p[v]) {
            continue;                                                /* it is below or beside the ray */
        }
        for (j = 0; j < 3; j++) {
            corner[j][0] = pbwsample__corner(grid->model, t, j)[u];
            corner[j][1] = pbwsample__corner(grid->model, t, j)[v];
        }
        turn = pbwsample__side(corner[0], corner[1], q);
        if (pbwsample__side(corner[1], corner[2], q) == turn && pbwsample__side(corner[2], corner[0], q) == turn) {
            odd ^= pbw_orient3(pbwsample__corner(grid->model, t, 0), pbwsample__corner(grid->model, t, 1),
                               pbwsample__corner(grid->model, t, 2), p) * turn < 0;
        }
    }
    return odd;
}

/* One axis for a closed surface, three for any other: *axes. */
static pbw_status pbwsample__make_grids(pbw_memory *memory, pbwsample__columns grid[3], const pbwsample_model *model,
                                        const pbw_options *options, int *axes)
{
    pbwsample_report report;
    pbw_status status = pbwsample__inspect(memory, model, options, 0, &report);
    int i;
    memset(grid, 0, 3 * sizeof *grid);
    *axes = report.closed ? 1 : 3;
    for (i = 0; i < *axes && status == PBW_OK; i++) {
        status = pbwsample__make_columns(memory, grid + i, model, 2 - i) ? PBW_OK : PBW_ERROR_MEMORY;
    }
    for (i = 0; i < 3 && status != PBW_OK; i++) {
        pbwsample__free_columns(memory, grid + i);
    }
    return status;
}

static int pbwsample__is_inside(const pbwsample__columns *grid, int axes, const double p[3])
{
    int votes = pbwsample__crosses_odd(grid, p);
    if (axes == 3) {
        votes = (votes + pbwsample__crosses_odd(grid + 1, p) + pbwsample__crosses_odd(grid + 2, p)) / 2;
    }
    return votes;
}

typedef struct pbwsample__inside_work {
    pbwsample__columns grid[3];
    int axes;
    const double *points;
    unsigned char *inside;
} pbwsample__inside_work;

static pbw_status pbwsample__inside_range(void *arg, size_t begin, size_t end)
{
    const pbwsample__inside_work *w = (const pbwsample__inside_work *)arg;
    size_t i;
    for (i = begin; i < end; i++) {
        w->inside[i] = (unsigned char)pbwsample__is_inside(w->grid, w->axes, w->points + 3 * i);
    }
    return PBW_OK;
}

PBWDEF pbw_status pbwsample_inside(const pbwsample_model *model, const double *points, size_t count,
                                   const pbw_options *options, unsigned char *inside)
{
    pbwsample__inside_work w;
    pbw_memory memory;
    pbw_options build;
    int i;
    pbw_status status = pbwsample__check_model(model);
    if (status != PBW_OK || points == NULL || inside == NULL) {
        return status != PBW_OK ? status : PBW_ERROR_ARGUMENT;
    }
    memset(&build, 0, sizeof build);
    build = options != NULL ? *options : build;
    pbw_memory_start(&memory, options);
    pbw_memory_nest(&memory, &build);
    w.points = points;
    w.inside = inside;
    status = pbwsample__make_grids(&memory, w.grid, model, options, &w.axes);
    if (status == PBW_OK) {
        status = pbw_for(&build, count, 4096, pbwsample__inside_range, &w);
        for (i = 0; i < w.axes; i++) {
            pbwsample__free_columns(&memory, w.grid + i);
        }
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>balls        Poisson sets: samples as centres of balls, found by a hashed grid.
   In: points.  Out: samples, each the centre of a ball; the balls at a point, or near it.
   Holds: no sample lies in the ball of an earlier one; with PBWSAMPLE_THIN, balls of facets
   that look away from its own do not count.

   1. Darts are thrown at pieces: triangles, cut at their longest edge, or boxes, cut in eight (White, Cline and
      Egbert 2007, "Poisson disk point sets by hierarchical dart throwing"; Cline et al. 2009, "Dart throwing on
      surfaces").
   2. A dart that is in no ball becomes a sample, the centre of a ball.
   3. A piece inside one ball is done, any other is cut.  When no piece is left, there is no room left.
   4. Each round visits all pieces once, in random order, so that gaps are filled from wide to narrow: the last
      samples are the least important ones.
   5. Most boxes lie in several balls but not in a single one.  Cutting them to find the last gaps would make about a
      hundred for each sample.  So a box is done when it is in a ball of 1.25 times the radius: only narrow gaps stay.

   The grid has a level for each power of two of radii.  A ball is listed in all cells that it may touch, about eight,
   so a point reads one cell a level.  A ball that contains the whole piece also contains the dart, so one search
   finds both; the other balls that it meets tell which parts of the piece are done.
   ------------------------------------------------------------------------------------------------------ */
#define PBWSAMPLE__ONE 2147483648u             /* coordinates in a piece count in units of 2^-31 of the whole */
#define PBWSAMPLE__LISTED 15
#define PBWSAMPLE__CUTS 5                      /* cuts to find out whether several balls cover a part */
#define PBWSAMPLE__NEAR 32                     /* balls that are tried for the parts of a piece */
#define PBWSAMPLE__SHUFFLED 512                /* pieces whose order is drawn at once: few, for the cache's sake */

typedef struct pbwsample__piece {
    pbw_index triangle;                        /* PBW_NONE: a box */
    uint32_t at[6];                            /* triangle: u and v of three corners; box: x y z of the low corner,
                                                  the side, and 1 if it is known to be inside */
} pbwsample__piece;

typedef PBW_ARRAY(pbwsample__piece) pbwsample__pieces;
typedef struct pbwsample__ball { double at[3], r; } pbwsample__ball;
typedef struct pbwsample__chunk { pbw_index ids[PBWSAMPLE__LISTED], next; } pbwsample__chunk;

typedef struct pbwsample__work {
    const pbwsample_model *model;
    const pbwsample_options *options;
    pbw_memory *memory;
    pbw_status status;
    pbwsample_set *set;
    size_t fixed;                              /* samples of the set that were there before */
    double radius, low[3], high[3], unit;      /* of the boxes */
    uint64_t key, drawn;
    int solid, axes, too_many;
    pbwsample__columns rays[3];
    pbwsample__pieces pieces, next, stack;
    pbwsample__ids lists;                      /* of triangles, for the boxes on the stack */
    PBW_ARRAY(pbwsample__ball) balls;          /* by samples */
    PBW_ARRAY(pbwsample__chunk) chunks;
    pbwsample__table cells;
    pbwsample__ball nearby[PBWSAMPLE__NEAR];   /* those around the last dart */
    int near_count;
    int levels, level[64];                     /* those in use; at level l cells have the side 2^(l+1) radius */
    double scale[64];                          /* one over the side */
} pbwsample__work;

static uint64_t pbwsample__draw(pbwsample__work *w)
{
    return pbw_random(w->key, w->drawn++);
}

static double pbwsample__radius_at(pbwsample__work *w, const double p[3])
{
    double size = pbwsample__size_at(w->options, p);
    if (!(size > 1 / 2147483648.0 && size < 2147483648.0)) {
        w->status = PBW_ERROR_ARGUMENT;
        size = 1;
    }
    return w->radius * size;
}

static uint64_t pbwsample__cell_key(int level, int64_t x, int64_t y, int64_t z)
{
    const uint64_t mask = 0x7ffff;             /* cells that are as far apart as this may share a list: no harm */
    return (uint64_t)(level + 32) << 57 | ((uint64_t)x & mask) << 38 | ((uint64_t)y & mask) << 19
         | ((uint64_t)z & mask);
}

/* The number of a cell, rounded towards 0, from -1 up.  A model may be larger than 4e18 radii: what is beyond is one
   cell.  The scale is finite, as no radius is below a 65536th of the root of an area above 0. */
static int64_t pbwsample__cell(double offset, double scale)
{
    double cell = offset * scale;
    return (int64_t)(cell < 4e18 ? cell : 4e18);
}

/* Lists the next ball, number id, which is at p. */
static void pbwsample__list_ball(pbwsample__work *w, size_t id, const double p[3], double r)
{
    int level, i, k;
    int64_t from[3], to[3], x, y, z;
    pbwsample__ball ball;
    memcpy(ball.at, p, sizeof ball.at);
    ball.r = r;
    if (!PBW_PUSH(w->memory, w->balls, ball)) {
        w->status = PBW_ERROR_MEMORY;
        return;
    }
    level = frexp(r / w->radius, &level) > 0.5 ? level : level - 1;  /* the least that has 2^level radius >= r */
    for (i = 0; i < w->levels && w->level[i] != level; i++) { }
    if (i == w->levels) {
        w->level[w->levels] = level;
        w->scale[w->levels++] = 1 / ldexp(w->radius, level + 1);
    }
    for (k = 0; k < 3; k++) {
        from[k] = pbwsample__cell(p[k] - r - w->low[k], w->scale[i]);
        to[k] = pbwsample__cell(p[k] + r - w->low[k], w->scale[i]);
    }
    for (z = from[2]; z <= to[2]; z++) {
        for (y = from[1]; y <= to[1]; y++) {
            for (x = from[0]; x <= to[0]; x++) {
                pbw_index *value = pbwsample__enter(w->memory, &w->cells, pbwsample__cell_key(level, x, y, z));
                pbwsample__chunk *chunk = value != NULL && *value != PBW_NONE ? w->chunks.at + *value : NULL;
                if (value != NULL && (chunk == NULL || chunk->ids[PBWSAMPLE__LISTED - 1] != PBW_NONE)) {
                    chunk = NULL;
                    if (w->chunks.count < PBW_NONE && PBW_RESERVE(w->memory, w->chunks, 1)) {
                        chunk = w->chunks.at + w->chunks.count;
                        memset(chunk, 0xff, sizeof *chunk);          /* PBW_NONE in all of it */
                        chunk->next = *value;
                        *value = (pbw_index)w->chunks.count++;
                    }
                }
                if (chunk == NULL) {
                    w->status = PBW_ERROR_MEMORY;
                    return;
                }
                for (k = 0; chunk->ids[k] != PBW_NONE; k++) { }
                chunk->ids[k] = (pbw_index)id;
            }
        }
    }
}

/* Returns whether two triangles look away from each other. */
static int pbwsample__opposed(const pbwsample_model *model, pbw_index a, pbw_index b)
{
    double n[3], m[3];
    if (a == PBW_NONE || b == PBW_NONE) {
        return 0;
    }
    pbwsample__facet_normal(model, a, n);
    pbwsample__facet_normal(model, b, m);
    return pbwsample__dot(n, m) < 0;
}

/* The first chunk of the list of the cell that p is in, at that level. */
static pbw_index pbwsample__list_at(const pbwsample__work *w, int level, const double p[3])
{
    double scale = w->scale[level];
    uint64_t key = pbwsample__cell_key(w->level[level], pbwsample__cell(p[0] - w->low[0], scale),
                                       pbwsample__cell(p[1] - w->low[1], scale),
                                       pbwsample__cell(p[2] - w->low[2], scale));
    return pbwsample__slot_of(&w->cells, key)->value;
}

/* Gathers in w->near the balls within a distance of p, as far as the cell of p lists them.  Returns the radius of one
   that p is in, 0 if there is none.  Few branches depend on where p is. */
static double pbwsample__find_balls(pbwsample__work *w, const double p[3], double distance, pbw_index triangle)
{
    double radius = 0;
    int level, i, count = 0;
    for (level = 0; level < w->levels; level++) {
        pbw_index at = pbwsample__list_at(w, level, p);
        while (at != PBW_NONE) {
            const pbwsample__chunk *chunk = w->chunks.at + at;
            for (i = 0; i < PBWSAMPLE__LISTED && chunk->ids[i] != PBW_NONE; i++) {
                const pbwsample__ball *ball = w->balls.at + chunk->ids[i];
                double square = pbwsample__square(ball->at, p), reach = ball->r + distance;
                int hit = square < ball->r * ball->r;
                if (w->options->flags & PBWSAMPLE_THIN && square < reach * reach
                    && pbwsample__opposed(w->model, triangle, w->set->triangles[chunk->ids[i]])) {
                    continue;
                }
                w->nearby[count] = *ball;
                radius = hit ? ball->r : radius;
                count += (square < reach * reach) & (count < PBWSAMPLE__NEAR - 1);
            }
            at = chunk->next;
        }
    }
    w->near_count = count;
    return radius;
}

/* Bit i is set if p is in ball i of w->near. */
static uint32_t pbwsample__mask(const pbwsample__work *w, const double p[3])
{
    uint32_t mask = 0;
    int i;
    for (i = 0; i < w->near_count; i++) {
        const pbwsample__ball *ball = w->nearby + i;
        mask |= (uint32_t)(pbwsample__square(ball->at, p) <= ball->r * ball->r) << i;
    }
    return mask;
}

/* r: of its ball, 0 = it has none. */
static void pbwsample__add_sample(pbwsample__work *w, const double p[3], double r, pbw_index triangle, double u,
                                  double v)
{
    pbwsample_set *set = w->set;
    size_t i = set->count;
    if (i + 1 >= PBW_NONE) {
        w->status = PBW_ERROR_TOO_LARGE;
    } else if (!pbwsample__reserve(set, 1, set->normals != NULL ? PBWSAMPLE_NORMALS : 0)) {
        w->status = PBW_ERROR_MEMORY;
    } else {
        memcpy(set->points + 3 * i, p, 3 * sizeof *p);
        set->triangles[i] = triangle;
        set->places[2 * i] = u;
        set->places[2 * i + 1] = v;
        if (set->normals != NULL) {
            memset(set->normals + 3 * i, 0, 3 * sizeof *set->normals);
        }
        set->count++;
        if (r > 0) {
            pbwsample__list_ball(w, i, p, r);
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>pieces       Poisson sets: triangles and boxes, cut to parts.
   In: a piece, the balls near it.  Out: its corners; its parts; what of it lies in no ball; whether it is inside.
   Holds: corners of pieces are whole numbers of units of 2^-31, so halves meet exactly.
   ------------------------------------------------------------------------------------------------------ */

/* The corners of a piece, where places in it count from.  Returns how many they are. */
static int pbwsample__corners(const pbwsample__work *w, const pbwsample__piece *piece, double corner[8][3])
{
    int i, k;
    if (piece->triangle == PBW_NONE) {
        for (i = 0; i < 24; i++) {
            k = i % 3;
            corner[i / 3][k] = w->low[k] + w->unit * ((double)piece->at[k] + (i / 3 >> k & 1) * (double)piece->at[3]);
        }
        return 8;
    }
    for (i = 0; i < 3; i++) {
        const double *a = pbwsample__corner(w->model, piece->triangle, 0);
        const double *b = pbwsample__corner(w->model, piece->triangle, 1);
        const double *c = pbwsample__corner(w->model, piece->triangle, 2);
        double u = (double)piece->at[2 * i] / PBWSAMPLE__ONE, v = (double)piece->at[2 * i + 1] / PBWSAMPLE__ONE;
        for (k = 0; k < 3; k++) {
            corner[i][k] = a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]);
        }
    }
    return 3;
}

/* The longest edge of a triangle by the number of the corner across, 3 = the diagonal of a box; its square. */
static int pbwsample__longest(double (*corner)[3], int corners, double *square)
{
    double edge[3];
    int i;
    if (corners == 8) {
        *square = pbwsample__square(corner[0], corner[7]);
        return 3;
    }
    edge[0] = pbwsample__square(corner[1], corner[2]);
    edge[1] = pbwsample__square(corner[2], corner[0]);
    edge[2] = pbwsample__square(corner[0], corner[1]);
    i = edge[0] >= edge[1] ? edge[0] >= edge[2] ? 0 : 2 : edge[1] >= edge[2] ? 1 : 2;
    *square = edge[i];
    return i;
}

static void pbwsample__push(pbwsample__work *w, pbwsample__pieces *pieces, const pbwsample__piece *piece)
{
    if (!PBW_PUSH(w->memory, *pieces, *piece)) {
        w->status = PBW_ERROR_MEMORY;
    }
}

static int pbwsample__meets(const pbwsample__box *box, const double low[3], const double high[3])
{
    return (box->low[0] <= high[0]) & (box->high[0] >= low[0]) & (box->low[1] <= high[1]) & (box->high[1] >= low[1])
         & (box->low[2] <= high[2]) & (box->high[2] >= low[2]);
}

/* Returns whether the box of some triangle meets a box. */
static int pbwsample__touches(const pbwsample__columns *grid, const double low[3], const double high[3])
{
    size_t x, y, i, begin[2], end[2];
    int k;
    for (k = 0; k < 2; k++) {
        begin[k] = pbwsample__column(grid, low[(grid->axis + 1 + k) % 3], k);
        end[k] = pbwsample__column(grid, high[(grid->axis + 1 + k) % 3], k);
    }
    for (y = begin[1]; y <= end[1]; y++) {
        for (x = begin[0]; x <= end[0]; x++) {
            for (i = grid->first.at[y * grid->side + x]; i < grid->first.at[y * grid->side + x + 1]; i++) {
                if (pbwsample__meets(grid->boxes.at + grid->list.at[i], low, high)) {
                    return 1;
                }
            }
        }
    }
    return 0;
}

/* Returns whether a part of a box may be inside; notes if all of it is.  at[5]: the place in w->lists of the number
   of triangles that the parent box meets, followed by these; it becomes the place of the box's own list, which is
   appended: as boxes are on a stack, later lists belong to boxes that are done. */
static int pbwsample__may_be_inside(pbwsample__work *w, pbwsample__piece *box)
{
    double corner[8][3], middle[3];
    size_t from = box->at[5], count = w->lists.at[from], to = from + 1 + count, met = 0, i;
    int k;
    if (box->at[4]) {
        return 1;
    }
    if (!PBW_RESERVE(w->memory, w->lists, to + 1 + count) || to >= PBW_NONE) {
        w->status = PBW_ERROR_MEMORY;
        return 0;
    }
    pbwsample__corners(w, box, corner);
    for (i = 1; i <= count; i++) {
        w->lists.at[to + 1 + met] = w->lists.at[from + i];
        met += (size_t)pbwsample__meets(w->rays[0].boxes.at + w->lists.at[from + i], corner[0], corner[7]);
    }
    w->lists.at[to] = (pbw_index)met;
    box->at[5] = (uint32_t)to;
    if (met == 0) {
        for (k = 0; k < 3; k++) {
            middle[k] = 0.5 * (corner[0][k] + corner[7][k]);
        }
        box->at[4] = (uint32_t)pbwsample__is_inside(w->rays, w->axes, middle);
    }
    return met > 0 || box->at[4];
}

/* Cuts a triangle at the edge across from corner number longest, or a box in eight.  Returns how many parts there
   are; a piece of one unit has none. */
static int pbwsample__cut(const pbwsample__piece *piece, int longest, pbwsample__piece part[8])
{
    int i, k, a = (longest + 1) % 3, b = (longest + 2) % 3, count = 0;
    uint32_t middle[2];
    if (longest == 3) {
        for (i = 0; i < 8 && piece->at[3] > 1; i++) {
            part[count] = *piece;
            part[count].at[3] /= 2;
            for (k = 0; k < 3; k++) {
                part[count].at[k] += i >> k & 1 ? part[count].at[3] : 0;
            }
            count++;
        }
        return count;
    }
    for (k = 0; k < 2; k++) {
        middle[k] = (uint32_t)(((uint64_t)piece->at[2 * a + k] + piece->at[2 * b + k]) / 2);
    }
    if (memcmp(middle, piece->at + 2 * a, sizeof middle) == 0
        || memcmp(middle, piece->at + 2 * b, sizeof middle) == 0) {
        return 0;
    }
    part[0] = part[1] = *piece;
    memcpy(part[0].at + 2 * a, middle, sizeof middle);
    memcpy(part[1].at + 2 * b, middle, sizeof middle);
    return 2;
}

/* Takes away the parts of a triangle that lie in one ball of w->near, by at most `cuts` cuts.  Stores in `left` the
   smallest part that holds the rest, or the rests of both halves if that is the whole piece.  Returns how many it
   stored, 0 to 2.  mask: the balls that hold each corner.  If a corner is in no ball, cutting does not help. */
static int pbwsample__uncovered(const pbwsample__work *w, const pbwsample__piece *piece, double (*corner)[3],
                                const uint32_t mask[3], int cuts, pbwsample__piece left[2])
{
    pbwsample__piece part[8], rest[2];
    double half[3][3], middle[3], square;
    uint32_t half_mask[3], middle_mask;
    int i, k, longest, a, b, count = 0, whole = cuts == PBWSAMPLE__CUTS;
    if ((mask[0] & mask[1] & mask[2]) != 0) {
        return 0;
    }
    left[0] = *piece;
    if (cuts == 0 || (!whole && (mask[0] == 0 || mask[1] == 0 || mask[2] == 0))) {
        return 1;
    }
    longest = pbwsample__longest(corner, 3, &square);
    if (pbwsample__cut(piece, longest, part) == 0) {
        return 0;
    }
    a = (longest + 1) % 3;
    b = (longest + 2) % 3;
    for (k = 0; k < 3; k++) {
        middle[k] = 0.5 * (corner[a][k] + corner[b][k]);
    }
    middle_mask = pbwsample__mask(w, middle);
    for (i = 0; i < 2; i++) {
        memcpy(half, corner, sizeof half);
        memcpy(half_mask, mask, sizeof half_mask);
        memcpy(half[i == 0 ? a : b], middle, sizeof middle);
        half_mask[i == 0 ? a : b] = middle_mask;
        if (pbwsample__uncovered(w, part + i, half, half_mask, cuts - 1, rest) > 0) {
            count++;
            left[whole ? count - 1 : 0] = count == 1 || whole ? rest[0] : *piece;
        }
    }
    return whole ? count : count > 0;
}

/* ------------------------------------------------------------------------------------------------------
   >>darts        Poisson sets: a dart at a piece.
   In: a piece.  Out: perhaps a sample; the parts of the piece that go to the next round.
   Holds: a part that goes nowhere lies in a ball, or is too small to count.
   ------------------------------------------------------------------------------------------------------ */

/* The square of the distance from p to the farthest corner of a box, given two of its corners. */
static double pbwsample__farthest(const double low[3], const double high[3], const double p[3])
{
    double sum = 0;
    int k;
    for (k = 0; k < 3; k++) {
        double below = p[k] - low[k], above = high[k] - p[k];
        double most = below > above ? below : above;
        sum += most * most;
    }
    return sum;
}

/* One dart at a box; the box goes to the next round in parts, unless all of it is within 1.25 radii of one sample.
   A box whose diagonal is a quarter of a radius is, if the dart is in a ball. */
static void pbwsample__throw_at_box(pbwsample__work *w, const pbwsample__piece *box)
{
    pbwsample__piece part[8];
    double low[3], high[3], p[3], r = 0, side = w->unit * (double)box->at[3];
    int level, i, k, count, covered = 0, outside = 0;
    for (k = 0; k < 3; k++) {
        low[k] = w->low[k] + w->unit * (double)box->at[k];
        high[k] = low[k] + side;
        p[k] = low[k] + pbwsample__low_half(pbwsample__draw(w)) * side;
    }
    for (level = 0; level < w->levels; level++) {
        pbw_index at = pbwsample__list_at(w, level, p);
        for (; at != PBW_NONE; at = w->chunks.at[at].next) {
            const pbwsample__chunk *chunk = w->chunks.at + at;
            for (i = 0; i < PBWSAMPLE__LISTED && chunk->ids[i] != PBW_NONE; i++) {
                const pbwsample__ball *ball = w->balls.at + chunk->ids[i];
                double square = ball->r * ball->r, apart = pbwsample__square(ball->at, p);
                r = apart < square ? ball->r : r;
                covered |= apart < 1.5625 * square && pbwsample__farthest(low, high, ball->at) <= 1.5625 * square;
                if (covered && r > 0) {
                    return;
                }
            }
        }
    }
    if (!(r > 0)) {
        r = pbwsample__radius_at(w, p);
        outside = !box->at[4] && !pbwsample__is_inside(w->rays, w->axes, p);
        if (!outside) {
            pbwsample__add_sample(w, p, r, PBW_NONE, 0, 0);
            covered |= pbwsample__farthest(low, high, p) <= 1.5625 * r * r;
        }
    }
    if (!covered && 48 * side * side >= r * r && (!outside || pbwsample__touches(w->rays, low, high))) {
        count = pbwsample__cut(box, 3, part);
        for (i = 0; i < count; i++) {
            pbwsample__push(w, &w->next, part + i);
        }
    }
}

/* One dart at a triangle; what is left of it goes to the next round in parts. */
static void pbwsample__throw_at_triangle(pbwsample__work *w, const pbwsample__piece *piece)
{
    pbwsample__piece part[2];
    double corner[8][3], p[3], square, r;
    uint64_t bits = pbwsample__draw(w);
    double u = pbwsample__low_half(bits), v = pbwsample__low_half(bits >> 32), place[2];
    uint32_t mask[3];
    int i, count;
    pbwsample__corners(w, piece, corner);
    pbwsample__longest(corner, 3, &square);
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    for (i = 0; i < 3; i++) {
        p[i] = corner[0][i] + u * (corner[1][i] - corner[0][i]) + v * (corner[2][i] - corner[0][i]);
    }
    r = pbwsample__find_balls(w, p, sqrt(square), piece->triangle);
    if (!(r > 0)) {
        r = pbwsample__radius_at(w, p);
        for (i = 0; i < 2; i++) {
            place[i] = ((1 - u - v) * piece->at[i] + u * piece->at[2 + i] + v * piece->at[4 + i]) / PBWSAMPLE__ONE;
        }
        pbwsample__add_sample(w, p, r, piece->triangle, place[0], place[1]);
        if (w->status != PBW_OK) {
            return;
        }
        w->nearby[0] = w->balls.at[w->set->count - 1];                  /* likely enough for all of it */
        w->near_count = 1;
    }
    for (i = 0; i < 3; i++) {
        mask[i] = pbwsample__mask(w, corner[i]);
    }
    if ((mask[0] & mask[1] & mask[2]) == 0 && square >= r * r / 1099511627776.0) {
        count = pbwsample__uncovered(w, piece, corner, mask, PBWSAMPLE__CUTS, part);
        for (i = 0; i < count; i++) {
            pbwsample__push(w, &w->next, part + i);
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>sets         Poisson sets: rounds, the radius for a count.
   In: a model, a radius or a count.  Out: a set.
   Holds: on failure the set is as it was before the call.
   ------------------------------------------------------------------------------------------------------ */

/* The triangles by the cells of a grid that their first corners are in, and those along a Z-order curve: pieces are
   near those that they follow.  Returns 0 = out of memory. */
static int pbwsample__in_order(pbwsample__work *w, double extent, pbwsample__ids *order)
{
    size_t count = w->model->triangle_count, i, sum = 0;
    pbwsample__ids first = { NULL, 0, 0 };
    int bits = 1, pass, k, bit, done;
    while (bits < 7 && (size_t)1 << 3 * bits < count) {
        bits++;
    }
    done = PBW_FIT(w->memory, *order, count) && PBW_ZEROS(w->memory, first, ((size_t)1 << 3 * bits) + 1);
    for (pass = 0; pass < 2 && done; pass++) {                       /* count, then fill */
        for (i = 0; i < count; i++) {
            size_t key = 0;
            for (k = 0; k < 3; k++) {
                double at = (pbwsample__corner(w->model, i, 0)[k] - w->low[k]) / extent;
                unsigned cell = (unsigned)(at * ((1 << bits) - 1));
                for (bit = 0; bit < bits; bit++) {
                    key |= (size_t)(cell >> bit & 1) << (3 * bit + k);
                }
            }
            if (pass == 0) {
                first.at[key + 1]++;
            } else {
                order->at[first.at[key]++] = (pbw_index)i;
            }
        }
        for (i = 0; pass == 0 && i < (size_t)1 << 3 * bits; i++) {
            first.at[i] = (pbw_index)(sum += first.at[i]);
        }
    }
    PBW_RELEASE(w->memory, first);
    return done;
}

static void pbwsample__report(pbwsample__work *w, size_t i, double done)
{
    if (w->status == PBW_OK && pbwsample__stops(w->options->build, i, done)) {
        w->status = PBW_CANCELLED;
    }
}

/* Cuts the surface or volume to pieces that fit into a ball, or to lattice cells.  With a count, a radius that makes
   far more pieces than samples is too small, as may be for a needle or a sheet: too_many is set then. */
static void pbwsample__cut_model(pbwsample__work *w, double side)
{
    pbwsample__piece piece, part[8];
    double corner[8][3], middle[3], square, r, extent = 0;
    pbwsample__ids order = { NULL, 0, 0 };
    size_t t, steps = 0;
    int i, k, corners, longest, lattice = w->solid && w->options->flags & PBWSAMPLE_LATTICE;
    double most = w->options->count > 0
                ? 1024.0 * (double)w->options->count + 64.0 * (double)w->model->triangle_count + 4096 : DBL_MAX;
    w->pieces.count = w->stack.count = 0;
    w->too_many = 0;
    for (k = 0; k < 3; k++) {
        extent = w->high[k] - w->low[k] > extent ? w->high[k] - w->low[k] : extent;
    }
    for (i = 1; ldexp(side, i) <= extent; i++) { }
    w->unit = ldexp(side, i) / PBWSAMPLE__ONE;
    if (!(w->solid ? PBW_RESERVE(w->memory, w->lists, w->model->triangle_count + 1)
          : pbwsample__in_order(w, extent, &order))) {
        w->status = PBW_ERROR_MEMORY;
    }
    for (t = 0; w->solid && t <= w->model->triangle_count && w->status == PBW_OK; t++) {
        w->lists.at[t] = (pbw_index)(t == 0 ? w->model->triangle_count : t - 1);
    }
    for (t = 0; t < (w->solid ? 1 : w->model->triangle_count) && w->status == PBW_OK; t++) {
        memset(&piece, 0, sizeof piece);
        if (w->solid) {
            piece.triangle = PBW_NONE;
            piece.at[3] = PBWSAMPLE__ONE;
        } else if (pbwsample__area(w->model, order.at[t]) > 0) {
            piece.triangle = order.at[t];
            piece.at[2] = piece.at[5] = PBWSAMPLE__ONE;
        } else {
            continue;
        }
        pbwsample__push(w, &w->stack, &piece);
        while (w->stack.count > 0 && w->status == PBW_OK && !w->too_many) {
            piece = w->stack.at[--w->stack.count];
            pbwsample__report(w, ++steps, 0);
            w->too_many = (double)steps > most;
            if (w->solid && !pbwsample__may_be_inside(w, &piece)) {
                continue;
            }
            corners = pbwsample__corners(w, &piece, corner);
            for (k = 0; k < 3; k++) {
                middle[k] = corners == 8 ? 0.5 * (corner[0][k] + corner[7][k])
                          : (corner[0][k] + corner[1][k] + corner[2][k]) / 3;
            }
            r = pbwsample__radius_at(w, middle);
            longest = pbwsample__longest(corner, corners, &square);
            if (lattice ? w->unit * piece.at[3] * w->radius > 1.01 * side * r : square > 2 * r * r) {
                for (i = pbwsample__cut(&piece, longest, part); i > 0; i--) {
                    pbwsample__push(w, &w->stack, part + i - 1);
                }
            } else {
                pbwsample__push(w, &w->pieces, &piece);
            }
        }
    }
    PBW_RELEASE(w->memory, order);
}

/* A random order within stretches of the list. */
static void pbwsample__shuffle(pbwsample__work *w)
{
    size_t begin, i, j, count;
    for (begin = 0; begin < w->pieces.count; begin += PBWSAMPLE__SHUFFLED) {
        pbwsample__piece *list = w->pieces.at + begin, swap;
        count = w->pieces.count - begin < PBWSAMPLE__SHUFFLED ? w->pieces.count - begin : PBWSAMPLE__SHUFFLED;
        for (i = count; i > 1; i--) {
            j = (size_t)((pbwsample__draw(w) >> 32) * i >> 32);
            swap = list[j];
            list[j] = list[i - 1];
            list[i - 1] = swap;
        }
    }
}

/* A body-centred lattice (two points a cell), whose cells follow the size: its points are 0.87 sides apart.  Points
   in balls are left out. */
static void pbwsample__lattice(pbwsample__work *w)
{
    double jitter = w->options->jitter > 0 ? w->options->jitter : w->options->jitter < 0 ? 0 : 0.1, p[3];
    size_t i;
    int half, k;
    for (i = 0; i < w->pieces.count && w->status == PBW_OK; i++) {
        const pbwsample__piece *cell = w->pieces.at + i;
        pbwsample__report(w, i, (double)i / (double)w->pieces.count);
        for (half = 0; half < 2; half++) {
            for (k = 0; k < 3; k++) {
                double move = jitter * (pbwsample__low_half(pbwsample__draw(w)) - 0.5);
                p[k] = w->low[k] + w->unit * ((double)cell->at[k] + (0.5 * half + move) * (double)cell->at[3]);
            }
            if (pbwsample__is_inside(w->rays, w->axes, p)
                && !(pbwsample__find_balls(w, p, 0, PBW_NONE) > 0)) {
                pbwsample__add_sample(w, p, 0, PBW_NONE, 0, 0);
            }
        }
    }
}

/* One set with the present radius. */
static void pbwsample__make_set(pbwsample__work *w)
{
    int lattice = w->solid && w->options->flags & PBWSAMPLE_LATTICE, round;
    double side = w->radius * (lattice ? 1.4 : 0.577);               /* 1.4: as dense as blue noise;  1/sqrt 3 */
    size_t i;
    w->set->count = w->fixed;
    w->drawn = w->chunks.count = w->balls.count = 0;
    w->levels = 0;
    pbwsample__free_table(w->memory, &w->cells);
    if (pbwsample__enter(w->memory, &w->cells, 0) == NULL) {                    /* so that there are slots */
        w->status = PBW_ERROR_MEMORY;
    }
    for (i = 0; i < w->fixed && w->status == PBW_OK; i++) {
        pbwsample__list_ball(w, i, w->set->points + 3 * i, pbwsample__radius_at(w, w->set->points + 3 * i));
    }
    pbwsample__cut_model(w, side);
    if (lattice) {
        pbwsample__lattice(w);
        return;
    }
    for (round = 1; w->pieces.count > 0 && w->status == PBW_OK && !w->too_many; round++) {   /* takes half */
        pbwsample__pieces swap = w->pieces;
        pbwsample__shuffle(w);
        w->next.count = 0;
        for (i = 0; i < w->pieces.count && w->status == PBW_OK; i++) {
            pbwsample__report(w, i, 1 - ldexp(1 - 0.5 * (double)i / (double)w->pieces.count, 1 - round));
            if (w->solid) {
                pbwsample__throw_at_box(w, w->pieces.at + i);
            } else {
                pbwsample__throw_at_triangle(w, w->pieces.at + i);
            }
        }
        w->pieces = w->next;
        w->next = swap;
    }
}

/* Searches the radius for a count.  Sets on large smooth surfaces have 0.69 samples per squared radius, in large
   volumes 0.61 per cubed radius; the search starts slightly below.  A volume has more samples at its boundary, in
   proportion to the radius; an eighth of the samples tells how many.  The search ends with a few samples too many;
   the last ones are left out. */
static void pbwsample__search(pbwsample__work *w, double content)
{
    double power = w->solid ? 1.0 / 3 : 0.5, wanted = (double)w->options->count, slope, found;
    double density = w->solid ? 0.61 : 0.685;
    int attempt, i, few = 0;                   /* few: a radius gave too few samples */
    w->radius = w->options->radius;
    if (w->options->count > 0) {
        w->radius = pow(density * content / (1.01 * wanted + 1), power);
    }
    if (w->solid && wanted >= 4096 && content / pow(w->radius, 3) < PBW_NONE) {
        w->radius *= 2;
        pbwsample__make_set(w);
        if (w->status != PBW_OK) {
            return;
        }
        slope = ((double)(w->set->count - w->fixed) * pow(w->radius, 3) / content - density) / w->radius;
        for (i = 0; i < 32 && !w->too_many; i++) {
            w->radius = pow(fabs(density + slope * w->radius) * content / (1.01 * wanted), power);
        }
    }
    for (attempt = 1;; attempt++) {
        if (!(w->radius > 0 && content / pow(w->radius, 1 / power) < PBW_NONE)) {
            w->status = PBW_ERROR_TOO_LARGE;
        } else {
            pbwsample__make_set(w);
        }
        found = (double)(w->set->count - w->fixed);
        if (w->status != PBW_OK || wanted == 0) {
            return;
        }
        if (w->too_many) {                      /* it ends, as a radius that makes few pieces gives few samples */
            w->radius *= 2;
            w->status = !few || attempt <= 16 ? PBW_OK
                      : w->solid ? PBW_DEGENERATE : PBW_ERROR_TOO_LARGE;
            attempt -= !few;
            continue;
        }
        few |= found < wanted;
        if (found >= wanted && (found <= 1.04 * wanted + 2 || attempt > 4)) {
            w->set->count = w->fixed + w->options->count;
            return;
        }
        w->radius *= attempt > 4 ? 0.9 : pow((found + 0.5) / (1.015 * wanted + 1), power);
    }
}

static pbw_status pbwsample__poisson(const pbwsample_model *model, const pbwsample_options *options,
                                           pbwsample_set *set, int solid)
{
    pbwsample__work work, *w = &work;
    pbwsample__doubles computed = { NULL, 0, 0 };
    double content = 0;
    pbwsample__box all = pbwsample__box_of(model, 0), box;
    size_t i;
    int k;
    memset(w, 0, sizeof *w);
    w->model = model;
    w->options = options;
    w->set = set;
    w->memory = &set->memory;
    w->solid = solid;
    w->fixed = set->count;
    w->key = pbw_random(1 + (uint64_t)solid, options->seed);
    for (i = 0; i < model->triangle_count; i++) {
        content += solid ? 0 : pbwsample__area(model, i);
        box = pbwsample__box_of(model, i);
        pbwsample__unite(&all, &box);
    }
    memcpy(w->low, all.low, sizeof w->low);
    memcpy(w->high, all.high, sizeof w->high);
    if (solid) {
        content = fabs(pbwsample__volume_of(model));
        w->status = pbwsample__make_grids(w->memory, w->rays, model, options->build, &w->axes);
        w->axes = w->status == PBW_OK ? w->axes : 0;
        w->status = w->status == PBW_OK && !(content > 0) ? PBW_DEGENERATE : w->status;
    } else if (options->flags & PBWSAMPLE_NORMALS) {
        w->status = (model->normals != NULL || pbwsample__point_normals(w->memory, model, &computed))
                 && pbwsample__reserve(set, 1, options->flags) ? PBW_OK : PBW_ERROR_MEMORY;
    }
    if (w->status == PBW_OK) {
        pbwsample__search(w, content);
    }
    if (w->status == PBW_OK && set->count == 0) {
        w->status = PBW_DEGENERATE;
    }
    if (w->status == PBW_OK && !solid && set->normals != NULL) {
        const double *normals = model->normals != NULL ? model->normals : computed.at;
        pbwsample__set_normals(model, options->flags & PBWSAMPLE_FACET_NORMALS ? NULL : normals,
                               model->normals != NULL && model->normal_ids != NULL ? model->normal_ids
                               : model->triangles,
                               set, 0, set->count);
    }
    if (w->status != PBW_OK) {
        set->count = w->fixed;
    } else if (!solid || !(options->flags & PBWSAMPLE_LATTICE)) {
        set->radius = w->radius;
    }
    for (k = 0; k < w->axes; k++) {
        pbwsample__free_columns(w->memory, w->rays + k);
    }
    PBW_RELEASE(w->memory, computed);
    PBW_RELEASE(w->memory, w->pieces);
    PBW_RELEASE(w->memory, w->next);
    PBW_RELEASE(w->memory, w->stack);
    PBW_RELEASE(w->memory, w->lists);
    PBW_RELEASE(w->memory, w->balls);
    PBW_RELEASE(w->memory, w->chunks);
    pbwsample__free_table(w->memory, &w->cells);
    return w->status;
}

PBWDEF pbw_status pbwsample_poisson(const pbwsample_model *model, const pbwsample_options *options,
                                    pbwsample_set *set)
{
    pbw_status status = pbwsample__check_model(model);
    if (status == PBW_OK && (options == NULL || set == NULL || (options->count > 0) == (options->radius > 0))) {
        status = PBW_ERROR_ARGUMENT;
    }
    if (status == PBW_OK) {
        memset(set, 0, sizeof *set);
        pbw_memory_start(&set->memory, options->build);
        status = options->count >= PBW_NONE ? PBW_ERROR_TOO_LARGE : pbwsample__poisson(model, options, set, 0);
    }
    if (status != PBW_OK && set != NULL && options != NULL) {
        pbwsample_free(set);
    }
    return status;
}

PBWDEF pbw_status pbwsample_volume(const pbwsample_model *model, const pbwsample_options *options, pbwsample_set *set)
{
    pbw_status status = pbwsample__check_model(model);
    pbwsample_options copy;
    if (status != PBW_OK || options == NULL || set == NULL) {
        return status != PBW_OK ? status : PBW_ERROR_ARGUMENT;
    }
    if (set->memory.resize == NULL) {
        if (set->points != NULL) {
            return PBW_ERROR_ARGUMENT;                               /* arrays of another origin */
        }
        pbw_memory_start(&set->memory, options->build);
    }
    set->memory.limit = options->build != NULL ? options->build->memory_limit : 0;
    copy = *options;
    copy.radius = copy.count == 0 && !(copy.radius > 0) ? set->radius : copy.radius;
    if ((copy.count > 0) == (copy.radius > 0) || (copy.count > 0 && copy.flags & PBWSAMPLE_LATTICE)) {
        return PBW_ERROR_ARGUMENT;
    }
    return copy.count >= PBW_NONE ? PBW_ERROR_TOO_LARGE : pbwsample__poisson(model, &copy, set, 1);
}

PBW_CONTRACTION_ON
#endif /* PBW_SAMPLE_IMPLEMENTATION */
