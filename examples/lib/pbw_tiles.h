/* pbw_tiles.h - v0.2.0 - one exact triangulation in parts: over many machines, or one after the other - MIT-0

   QUICK START
   In one source file, define PBW_TILES_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, with its implementation in some source file.  The header moves no data between parts: the caller
   carries byte strings, by MPI, by files or, for parts in one process, by hand:

       pbwt_cut_points(dim, sample, samples, parts, cuts);           // pbwt_part tells the part of a point
       pbwt_tree_make(dim, r, points, count, NULL, &tree);           // on each part r, of its points
       pbwt_summarise(&tree, &summary);                              // all parts get all summaries
       pbwt_open(&tile, &tree, summaries, parts, &options);
       for (pbwt_ask(&tile, &more); more; pbwt_ask(&tile, &more)) {  // works, calls options.emit with simplices
           for (p = 0; p < parts; p++) {                             // part p gets the request and replies
               if (tile.request[p].size == 0) continue;
               pbwt_answer(&its_tree, &its_served[r], &tile.request[p], NULL, summary.count, &reply);
               pbwt_take(&tile, p, reply.data, reply.size);          // back on part r
           }
       }                                                             // over MPI: goes on while any part has more
       pbwt_close(&tile);

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>sorting      records, in place
     >>partition    cuts between parts
     >>boxes        a hierarchy over points or parts
     >>trees        one part's points, sorted, and boxes over them
     >>balls        what a simplex may be in conflict with, by floating-point bounds
     >>walks        the lowest boxes that meet a box or a ball
     >>answers      the points that another part asks for
     >>tile         one part's state; its requests, and the replies
     >>levels       meshes, and which of their simplices are certain
     >>emission     which simplices are given out, and their links
     >>repair       the next level; the stages in order
     >>leftovers    vertices given up, by one part
     >>links        facets across parts

   FUNCTIONS
     pbwt_cut_points   cuts space into parts of nearly equal numbers of points
     pbwt_part         the part that a point is in
     pbwt_tree_make    a tree of a part's points, which it sorts
     pbwt_tree_over    a tree over points that are sorted
     pbwt_boxes_of     how many boxes the tree of so many points has
     pbwt_tree_free    frees a tree
     pbwt_summarise    what other parts must know of a part
     pbwt_answer       the points that another part asks for
     pbwt_served_free  frees the memory of what was answered
     pbwt_bytes_free   frees bytes
     pbwt_open         begins a tile
     pbwt_ask          works until answers of others are needed
     pbwt_take         takes an answer
     pbwt_close        ends a tile
     pbwt_leftovers    what a tile knows of points that tiles gave up
     pbwt_finish       triangulates these points in the end
     pbwt_match        links simplices across parts

   HOW
   Each part triangulates its own points and a halo of others, and finds which simplices at its own points may be
   wrong.  If the ball of one meets the box of another part, it asks that part for the points in conflict, and repairs
   these stars.
     certificate  A simplex is in the triangulation of all points if and only if no point is in conflict with it.
     one round    The set of points in conflict with a star never grows when points are added: a new simplex at a
                  vertex is below a convex combination of two old ones.  So a star with full answers is final after
                  one repair; truncated answers leave less to ask about.
     repair       The star of a vertex after an insertion is its star in the triangulation of its old neighbours and
                  the new points: those few are triangulated by themselves, and nothing is inserted.
     where        Parts are convex (lexicographic k-d cells), so only simplices with a foreign corner, those at the
                  hull, and those connected to them through simplices in doubt can be wrong.
     leftovers    Vertices given up (all points on one sphere ask about everything) are triangulated together with
                  the neighbours that others know of them: pbwt_leftovers, pbwt_finish.
   A simplex belongs to the part of its corner with the smallest id; simplices of vertices given up to the leftovers.

   PROMISES  (tests/test_tiles.c guards them)
     exact       the simplices of all parts are those of pbw_triangulate: the same hash, for any cuts and limits
     linked      pbwt_match completes the neighbours across parts
     bounded     answers and work are limited; what exceeds them becomes a leftover, never a wrong simplex
     in memory   a call holds at most memory_limit, the tile and its tree included
     sound       every failure is a status and leaves things freeable

   CONFIGURATION MACROS
     PBW_TILES_IMPLEMENTATION    in one source file: compile the implementation there
*/
#ifndef PBW_TILES_H
#define PBW_TILES_H
#ifndef PBW_H
#include "pbw.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pbwt_point { double x[3], weight; uint64_t id; } pbwt_point;      /* ids: all different; 2D: x[2] 0 */
typedef struct pbwt_vertex { pbwt_point point; uint32_t part, index; } pbwt_vertex;   /* index: in its part's tree */
typedef struct pbwt_box { double low[3], high[3], weight; } pbwt_box;            /* weight: the largest inside */
typedef struct pbwt_bytes { char *data; size_t size; } pbwt_bytes;

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */
/* ---- partition: bricks by recursive bisection, cut along the lexicographic order that begins with the cut's axis */

typedef struct pbwt_cut { double x[3]; int axis, unused; } pbwt_cut;

/* Fills parts-1 cuts that halve the sample again and again.  Reorders the sample. */
PBWDEF void pbwt_cut_points(int dim, pbwt_point *sample, size_t count, int parts, pbwt_cut *cuts);
PBWDEF int pbwt_part(int dim, const pbwt_cut *cuts, int parts, const pbwt_point *point);

/* ---- one part's points, along the Hilbert curve without duplicates, and boxes over them: flat arrays that may be
   mapped from a file.  Any number of threads may ask one tree at once, but not during pbwt_ask of its tile: this
   appends the halo to the points of a tree of pbwt_tree_make for a while, which may move points and boxes. */

#define PBWT_LEAF 32                       /* points under a box of the lowest level */
#define PBWT_ARITY 8                       /* boxes under a box */
#define PBWT_SAMPLES 16                    /* points of a part that others know, all others if parts are few */
typedef struct pbwt_tree {                 /* start from {0}; read, do not write */
    int dim, part;
    size_t count, duplicates;              /* points kept, points removed */
    size_t box_count;
    const pbwt_point *points;
    const pbwt_box *boxes;                 /* the lowest level first, each level after the one below */
    uint32_t sample[PBWT_SAMPLES];         /* ascending */
    int samples;
    pbw_options options;                   /* threads, resize and so on of pbwt_tree_make */
    /* Of a tree over arrays that are not in memory yet: called by pbwt_answer before it reads bytes there.  NULL:
       they are. */
    void (*need)(void *user, const void *from, size_t size);
    void *need_user;
    size_t bytes;                          /* private: of one block with boxes, then points */
    void *memory;
} pbwt_tree;

typedef struct pbwt_summary {
    pbwt_box box;
    uint64_t count;
    pbwt_vertex sample[PBWT_SAMPLES];
    int32_t samples, unused;
} pbwt_summary;

/* Fails as pbw_order does; an empty part is fine.  Of points at one place the one with the largest weight stays, then
   that with the lowest id.  weight is 0 for Delaunay triangulations. */
PBWDEF pbw_status pbwt_tree_make(int dim, int part, const pbwt_point *points, size_t count,
                                 const pbw_options *options, pbwt_tree *tree);
/* A tree over arrays of an earlier one, for example mapped ones; summary: of that.  Free nothing but the arrays. */
PBWDEF void pbwt_tree_over(int dim, int part, const pbwt_summary *summary, const pbwt_point *points,
                           const pbwt_box *boxes, pbwt_tree *tree);
PBWDEF size_t pbwt_boxes_of(size_t points);         /* box_count of a tree over so many points */
PBWDEF void pbwt_tree_free(pbwt_tree *tree);
PBWDEF void pbwt_summarise(const pbwt_tree *tree, pbwt_summary *summary);

/* ---- answers to one other part.  Start from {0}; pbwt_served_free when that part has finished. */

typedef struct pbwt_limits {               /* 0 = default */
    size_t answer;                         /* points in an answer, 64; over it a sample of a third, and "more" */
    size_t halo_answer;                    /* the same for a box of the halo, 512, and a sample of 64 */
    size_t work;                           /* visits of boxes for one part by another, 20 a point of it.  Volumes need
                                              fewer; on surfaces, more of them leave fewer leftovers, later */
    size_t points;                         /* answered to one part by another, half as many as it has */
} pbwt_limits;

typedef struct pbwt_served {
    pbwt_bytes set;                        /* private: indices of points that were sent */
    size_t sent, visits;
} pbwt_served;

/* Appends nothing: reply is overwritten, and grown with the tree's options.resize; pbwt_bytes_free(tree, ..) frees.
   asker: the summary's count of the part that asks. */
PBWDEF pbw_status pbwt_answer(const pbwt_tree *tree, pbwt_served *served, const pbwt_bytes *request,
                              const pbwt_limits *limits, uint64_t asker, pbwt_bytes *reply);
PBWDEF void pbwt_served_free(const pbwt_tree *tree, pbwt_served *served);
PBWDEF void pbwt_bytes_free(const pbwt_tree *tree, pbwt_bytes *bytes);

/* ---- one part's work */

#define PBWT_HULL 0xffffffffu              /* links: no simplex across */
#define PBWT_OPEN 0xfffffffeu              /* the simplex across is another part's: the facet is in tile.facets */
typedef struct pbwt_facet {                /* ids ascending, in the plane the last is 0 */
    uint64_t id[3];
    uint64_t from;                         /* where it is: part << 40 | simplex << 2 | corner */
    uint64_t to;                           /* in a tile: the part that owns id[0], a good place for pbwt_match, which
                                              puts here what is across, or PBWT_NOTHING */
} pbwt_facet;
#define PBWT_NOTHING 0xffffffffffffffffu

typedef struct pbwt_tile pbwt_tile;
typedef struct pbwt_options {
    pbw_options build;                     /* threads, resize, progress, backend ... of a tile; memory_limit: of a
                                              tile and its tree */
    double halo;                           /* width in spacings; 0 = 1.5, below 0 = none */
    int weighted;                          /* 1: regular triangulation */
    double questions;                      /* a round and own point at most: else, as on surfaces, all points asked
                                              about are given up; 0 = 8, and 10,000 more */
    /* Called with count simplices of the tile, numbered on from `first`: dim+1 corners each, numbers < tree.count
       are own points, others tile.foreign[number - tree.count]; and their links.  NULL = only hash and counts. */
    pbw_status (*emit)(void *user, const pbwt_tile *tile, size_t first, size_t count, const uint32_t *corners,
                       const uint32_t *links);
    void *emit_user;
    int no_links;                          /* 1: links are not filled, facets not kept */
} pbwt_options;

typedef struct pbwt_numbers {              /* of one tile */
    size_t simplices, hull;                /* emitted; facets of the hull known to be */
    size_t halo, later;                    /* foreign points before and after the first questions */
    size_t tested, uncertified, questions, answered;      /* answered: with points */
    size_t rounds, patched, patch_points;  /* rounds of questions; stars and points of repairs */
    size_t given_up, sent_bytes;
} pbwt_numbers;

struct pbwt_tile {                         /* start from {0} */
    int dim, parts;
    pbwt_tree *tree;
    pbwt_bytes *request;                   /* one for each part, of pbwt_ask */
    const pbwt_vertex *foreign;
    size_t foreign_count;
    const pbwt_facet *facets;              /* to be matched: pbwt_match */
    size_t facet_count;
    const uint32_t *leftovers;             /* own points given up */
    size_t leftover_count;
    const uint32_t *border;                /* for pbwt_leftovers: simplices with a corner that may be given up */
    size_t border_count;                   /* a multiple of dim+1 */
    pbw_hash_sums hash;                    /* sums over own points and emitted simplices */
    pbwt_numbers numbers;
    struct pbwt__tile *memory;
};

/* summaries: of all parts, copied.  tree: refers to it; it may be one of count 0. */
PBWDEF pbw_status pbwt_open(pbwt_tile *tile, pbwt_tree *tree, const pbwt_summary *summaries, int parts,
                            const pbwt_options *options);
/* Works until other parts must be asked.  more: 1 = requests are filled (some may be empty: size 0), take all replies
   and ask again; 0 = finished, but for leftovers and facets.  A failed tile can only be closed. */
PBWDEF pbw_status pbwt_ask(pbwt_tile *tile, int *more);
/* PBW_ERROR_ARGUMENT for what is no reply to the request. */
PBWDEF pbw_status pbwt_take(pbwt_tile *tile, int part, const void *reply, size_t size);
PBWDEF void pbwt_close(pbwt_tile *tile);

/* ---- leftovers, if any part has some */

/* ids: ascending, of all vertices that any part gave up.  Returns in *out what this tile knows: its own ones among
   them, and those of its other points that are neighbours of some; free by pbwt_bytes_free(tile->tree, out).
   Reads dim, tree, foreign, leftovers, border and numbers.simplices of the tile, which may be kept in a file. */
PBWDEF pbw_status pbwt_leftovers(const pbwt_tile *tile, const uint64_t *ids, size_t count, pbwt_bytes *out);
/* known: what all tiles returned, one after the other.  Triangulates and emits the simplices of the leftovers, as
   part `parts`; corners are then numbers in tile.foreign.  PBW_DEGENERATE if all points together are flat. */
PBWDEF pbw_status pbwt_finish(pbwt_tile *tile, int dim, int parts, const pbwt_bytes *known,
                              const pbwt_options *options);

/* ---- links: fills `to` of facets of any parts (all that share an id[0] must be there) and sorts them by `from`, the
   order in which each tile has them.  Returns how many have nothing across: facets of the hull. */
PBWDEF size_t pbwt_match(pbwt_facet *facets, size_t count);

#ifdef __cplusplus
}
#endif
#endif /* PBW_TILES_H */

#if defined(PBW_TILES_IMPLEMENTATION) && !defined(PBWT__IMPLEMENTED)
#define PBWT__IMPLEMENTED

#include <math.h>
#include <string.h>

PBW_CONTRACTION_OFF

typedef PBW_ARRAY(unsigned char) pbwt__bytes;
typedef PBW_ARRAY(uint32_t) pbwt__numbers;
typedef PBW_ARRAY(pbwt_vertex) pbwt__vertices;
typedef PBW_ARRAY(pbwt_facet) pbwt__facets;

/* ------------------------------------------------------------------------------------------------------
   >>sorting      Records, in place.
   In: items of equal size, and a comparison.  Out: the items, ascending.  Quicksort with the median of three, heap
   sort where that goes too deep: n log n at worst, and no memory.
   ------------------------------------------------------------------------------------------------------ */
typedef int pbwt__before(const void *a, const void *b, int how);

typedef struct pbwt__sorting {
    size_t size;                                     /* of an item */
    pbwt__before *before;
    int how;
} pbwt__sorting;

static void pbwt__swap(char *a, char *b, size_t size)
{
    char hold[64];                                   /* the largest record */
    memcpy(hold, a, size);
    memcpy(a, b, size);
    memcpy(b, hold, size);
}

static void pbwt__heap_sort(const pbwt__sorting *s, char *data, size_t count)
{
    size_t heap = count / 2, end = count;
    while (end > 1) {
        size_t at, child;
        if (heap > 0) {
            heap--;
        } else {
            end--;
            pbwt__swap(data, data + end * s->size, s->size);
        }
        for (at = heap; 2 * at + 1 < end; at = child) {
            child = 2 * at + 1;
            child += child + 1 < end && s->before(data + child * s->size, data + (child + 1) * s->size, s->how);
            if (!s->before(data + at * s->size, data + child * s->size, s->how)) {
                break;
            }
            pbwt__swap(data + at * s->size, data + child * s->size, s->size);
        }
    }
}

/* Splits items, at least three, by one of them.  Returns its place: none before it is larger, none after smaller. */
static size_t pbwt__split(const pbwt__sorting *s, char *data, size_t count)
{
    char *first = data, *middle = data + count / 2 * s->size, *last = data + (count - 1) * s->size;
    size_t low = 0, high = count;
    if (s->before(middle, first, s->how)) {
        pbwt__swap(middle, first, s->size);
    }
    if (s->before(last, middle, s->how)) {
        pbwt__swap(last, middle, s->size);
    }
    if (s->before(first, middle, s->how)) {          /* the median of the three goes first */
        pbwt__swap(first, middle, s->size);
    }
    for (;;) {
        while (++low < count && s->before(data + low * s->size, data, s->how)) {
        }
        while (s->before(data, data + --high * s->size, s->how)) {
        }
        if (low >= high) {
            break;
        }
        pbwt__swap(data + low * s->size, data + high * s->size, s->size);
    }
    pbwt__swap(data, data + high * s->size, s->size);
    return high;
}

static void pbwt__sort(void *items, size_t count, size_t size, pbwt__before *before, int how)
{
    struct { char *data; size_t count; int depth; } stack[64], job;
    pbwt__sorting s;
    int jobs = 1;
    s.size = size;
    s.before = before;
    s.how = how;
    stack[0].data = (char *)items;
    stack[0].count = count;
    stack[0].depth = 0;
    while (jobs > 0) {
        size_t at;
        job = stack[--jobs];
        if (job.count < 12 || job.depth > 60) {
            pbwt__heap_sort(&s, job.data, job.count);
            continue;
        }
        at = pbwt__split(&s, job.data, job.count);
        stack[jobs].data = job.data;
        stack[jobs].count = at;
        stack[jobs++].depth = job.depth + 1;
        stack[jobs].data = job.data + (at + 1) * size;
        stack[jobs].count = job.count - at - 1;
        stack[jobs++].depth = job.depth + 1;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>partition    Cuts between parts.
   In: a sample of the points.  Out: cuts of recursive bisection, and the part of a point.
   Holds: cut b lies between the parts below b and those from b on, so that parts-1 cuts are an array.
   ------------------------------------------------------------------------------------------------------ */
static int pbwt__is_below(int dim, int axis, const double *a, const double *b)   /* lexicographic, from the axis on */
{
    int k;
    for (k = 0; k < dim; k++) {
        const int j = (axis + k) % dim;
        if (a[j] < b[j] || a[j] > b[j]) {
            return a[j] < b[j];
        }
    }
    return 0;
}

static int pbwt__point_before(const void *a, const void *b, int how)             /* how: dim + 4 * axis */
{
    return pbwt__is_below(how % 4, how / 4, ((const pbwt_point *)a)->x, ((const pbwt_point *)b)->x);
}

static int pbwt__longest(int dim, const pbwt_point *points, size_t count)
{
    double longest = -1;
    int k, axis = 0;
    for (k = 0; k < dim; k++) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        size_t i;
        for (i = 0; i < count; i++) {
            low = points[i].x[k] < low ? points[i].x[k] : low;
            high = points[i].x[k] > high ? points[i].x[k] : high;
        }
        if (high - low > longest) {
            longest = high - low;
            axis = k;
        }
    }
    return axis;
}

PBWDEF void pbwt_cut_points(int dim, pbwt_point *sample, size_t count, int parts, pbwt_cut *cuts)
{
    struct { int first, end; size_t from, to; } stack[64], job;
    int depth = 1;
    stack[0].first = 0;
    stack[0].end = parts;
    stack[0].from = 0;
    stack[0].to = count;
    while (depth > 0) {
        int middle;
        pbwt_cut *cut;
        size_t at;
        job = stack[--depth];
        if (job.end - job.first < 2) {
            continue;
        }
        middle = job.first + (job.end - job.first) / 2;
        cut = cuts + middle - 1;
        memset(cut, 0, sizeof *cut);
        at = job.from + (size_t)((double)(job.to - job.from) * (middle - job.first) / (job.end - job.first));
        if (at < job.to) {
            pbwt_point *part = sample + job.from;
            cut->axis = pbwt__longest(dim, part, job.to - job.from);
            pbwt__sort(part, job.to - job.from, sizeof *part, pbwt__point_before, dim + 4 * cut->axis);
            memcpy(cut->x, sample[at].x, sizeof cut->x);
        } else {
            cut->x[cut->axis] = HUGE_VAL;            /* no sample: all points go below */
        }
        stack[depth] = job;
        stack[depth].end = middle;
        stack[depth++].to = at;
        stack[depth] = job;
        stack[depth].first = middle;
        stack[depth++].from = at;
    }
}

PBWDEF int pbwt_part(int dim, const pbwt_cut *cuts, int parts, const pbwt_point *point)
{
    int first = 0, end = parts;
    while (end - first > 1) {
        const int middle = first + (end - first) / 2;
        const pbwt_cut *cut = cuts + middle - 1;
        if (pbwt__is_below(dim, cut->axis, point->x, cut->x)) {
            end = middle;
        } else {
            first = middle;
        }
    }
    return first;
}

/* ------------------------------------------------------------------------------------------------------
   >>boxes        A hierarchy over points in the order of the curve, or over the boxes of all parts.
   In: the lowest boxes.  Out: the levels above them.
   Holds: box i of a level is over boxes PBWT_ARITY*i ... of the level below.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWT__LEVELS = 14 };

typedef struct pbwt__levels {
    const pbwt_box *box[PBWT__LEVELS];
    size_t count[PBWT__LEVELS];
    int levels;                                      /* 0: there are no boxes */
    const pbwt_tree *tree;                           /* of which boxes are asked for, or NULL */
} pbwt__levels;

static size_t pbwt__level_boxes(size_t lowest)               /* of all levels */
{
    size_t count = lowest, all = lowest;
    while (count > 1) {
        count = (count + PBWT_ARITY - 1) / PBWT_ARITY;
        all += count;
    }
    return all;
}

static pbwt__levels pbwt__levels_over(const pbwt_box *boxes, size_t lowest)
{
    pbwt__levels l;
    size_t count = lowest;
    memset(&l, 0, sizeof l);
    while (count > 0) {
        l.box[l.levels] = boxes;
        l.count[l.levels++] = count;
        boxes += count;
        count = count > 1 ? (count + PBWT_ARITY - 1) / PBWT_ARITY : 0;
    }
    return l;
}

PBWDEF size_t pbwt_boxes_of(size_t points)
{
    return pbwt__level_boxes((points + PBWT_LEAF - 1) / PBWT_LEAF);
}

static void pbwt__box_clear(pbwt_box *box)
{
    int k;
    for (k = 0; k < 3; k++) {
        box->low[k] = HUGE_VAL;
        box->high[k] = -HUGE_VAL;
    }
    box->weight = -HUGE_VAL;
}

static void pbwt__box_add(pbwt_box *box, const double *low, const double *high, double weight)
{
    int k;
    for (k = 0; k < 3; k++) {
        box->low[k] = low[k] < box->low[k] ? low[k] : box->low[k];
        box->high[k] = high[k] > box->high[k] ? high[k] : box->high[k];
    }
    box->weight = weight > box->weight ? weight : box->weight;
}

static void pbwt__upper_boxes(pbwt_box *boxes, size_t lowest)        /* from those of the lowest level */
{
    size_t count = lowest, i, k;
    pbwt_box *below = boxes, *box;
    for (; count > 1; count = (count + PBWT_ARITY - 1) / PBWT_ARITY, below = box) {
        box = below + count;
        for (i = 0; i * PBWT_ARITY < count; i++) {
            pbwt__box_clear(box + i);
            for (k = i * PBWT_ARITY; k < count && k < (i + 1) * PBWT_ARITY; k++) {
                pbwt__box_add(box + i, below[k].low, below[k].high, below[k].weight);
            }
        }
    }
}

static pbwt__levels pbwt__tree_levels(const pbwt_tree *tree)
{
    pbwt__levels l = pbwt__levels_over(tree->boxes, (tree->count + PBWT_LEAF - 1) / PBWT_LEAF);
    l.tree = tree;
    return l;
}

static void pbwt__need(const pbwt_tree *tree, const void *from, size_t size)
{
    if (tree != NULL && tree->need != NULL) {
        tree->need(tree->need_user, from, size);
    }
}

/* The boxes below one, on a level above 0: returns the first, *end: the number after the last. */
static size_t pbwt__below(const pbwt__levels *levels, int level, size_t at, size_t *end)
{
    const size_t first = at * PBWT_ARITY, most = levels->count[level - 1];
    *end = first + PBWT_ARITY < most ? first + PBWT_ARITY : most;
    pbwt__need(levels->tree, levels->box[level - 1] + first, (*end - first) * sizeof(pbwt_box));
    return first;
}

/* ------------------------------------------------------------------------------------------------------
   >>trees        One part's points, sorted, and boxes over them.
   In: points of a part, in any order.  Out: pbwt_tree, and its summary for the other parts.
   Holds: of points at one place one is kept; the points behind the boxes, in one block, may be followed by others.
   ------------------------------------------------------------------------------------------------------ */
/* Returns the first of the points that are lowest, or highest, along an axis: in the first of such boxes. */
static uint32_t pbwt__extreme(const pbwt_tree *tree, int axis, int high)
{
    const double sign = high ? -1 : 1;
    const pbwt__levels levels = pbwt__tree_levels(tree);
    const pbwt_box *box = levels.box[0];
    size_t leaf = 0, first, i;
    for (i = 1; i < levels.count[0]; i++) {
        const double x = high ? box[i].high[axis] : box[i].low[axis];
        leaf = sign * x < sign * (high ? box[leaf].high[axis] : box[leaf].low[axis]) ? i : leaf;
    }
    first = leaf * PBWT_LEAF;
    for (i = first + 1; i < (leaf + 1) * PBWT_LEAF && i < tree->count; i++) {
        first = sign * tree->points[i].x[axis] < sign * tree->points[first].x[axis] ? i : first;
    }
    return (uint32_t)first;
}

/* Ten points spread along the curve, and those that are extreme along the axes. */
static void pbwt__choose_samples(pbwt_tree *tree)
{
    uint32_t pick[PBWT_SAMPLES];
    int k, j, n = 0;
    for (k = 0; k < PBWT_SAMPLES - 6; k++) {
        pick[n++] = (uint32_t)(tree->count * (size_t)(2 * k + 1) / (2 * (PBWT_SAMPLES - 6)));
    }
    for (k = 0; k < tree->dim && tree->count > 0; k++) {
        pick[n++] = pbwt__extreme(tree, k, 0);
        pick[n++] = pbwt__extreme(tree, k, 1);
    }
    tree->samples = 0;
    for (k = 0; k < n && tree->count > 0; k++) {
        for (j = tree->samples; j > 0 && tree->sample[j - 1] > pick[k]; j--) {
            tree->sample[j] = tree->sample[j - 1];
        }
        tree->sample[j] = pick[k];
        tree->samples++;
    }
    for (k = j = 0; k < tree->samples; k++) {                /* once each */
        if (k == 0 || tree->sample[k] != tree->sample[k - 1]) {
            tree->sample[j++] = tree->sample[k];
        }
    }
    tree->samples = j;
}

PBWDEF void pbwt_tree_over(int dim, int part, const pbwt_summary *summary, const pbwt_point *points,
                           const pbwt_box *boxes, pbwt_tree *tree)
{
    memset(tree, 0, sizeof *tree);
    tree->dim = dim;
    tree->part = part;
    tree->points = points;
    tree->count = (size_t)summary->count;
    tree->boxes = boxes;
    tree->box_count = pbwt_boxes_of(tree->count);
    for (tree->samples = 0; tree->samples < summary->samples; tree->samples++) {
        tree->sample[tree->samples] = summary->sample[tree->samples].index;
    }
}

typedef struct pbwt__making {
    const pbwt_point *points;
    pbwt_box *boxes;
    size_t count;
} pbwt__making;

static pbw_status pbwt__lowest_boxes(void *arg, size_t from, size_t to)
{
    const pbwt__making *making = (const pbwt__making *)arg;
    size_t i;
    for (; from < to; from++) {
        pbwt__box_clear(making->boxes + from);
        for (i = from * PBWT_LEAF; i < (from + 1) * PBWT_LEAF && i < making->count; i++) {
            const pbwt_point *p = making->points + i;
            pbwt__box_add(making->boxes + from, p->x, p->x, p->weight);
        }
    }
    return PBW_OK;
}

static int pbwt__same_place(const double *a, const double *b)
{
    return !(a[0] < b[0] || a[0] > b[0] || a[1] < b[1] || a[1] > b[1] || a[2] < b[2] || a[2] > b[2]);
}

enum { PBWT__AHEAD = 16 };                           /* points on their way from memory */

/* Copies points in that order, one for each place.  Returns how many. */
static size_t pbwt__gather(const pbwt_point *points, const pbw_index *order, size_t count, pbwt_point *out)
{
    size_t i, n = 0;
    for (i = 0; i < count; i++) {
        const pbwt_point *p = points + order[i];
        PBW_PREFETCH(points + order[i + PBWT__AHEAD < count ? i + PBWT__AHEAD : i]);
        if (n == 0 || !pbwt__same_place(p->x, out[n - 1].x)) {
            out[n++] = *p;
        } else if (p->weight > out[n - 1].weight
                   || (!(p->weight < out[n - 1].weight) && p->id < out[n - 1].id)) {
            out[n - 1] = *p;
        }
    }
    return n;
}

PBWDEF pbw_status pbwt_tree_make(int dim, int part, const pbwt_point *points, size_t count,
                                 const pbw_options *options, pbwt_tree *tree)
{
    pbw_options order_options, zero;
    pbw_memory memory;
    PBW_ARRAY(pbw_index) order = { NULL, 0, 0 };
    pbwt__bytes block = { NULL, 0, 0 };
    pbwt__making making;
    pbw_status status;
    size_t i;
    memset(&zero, 0, sizeof zero);
    memset(tree, 0, sizeof *tree);
    order_options = options != NULL ? *options : zero;
    pbw_memory_start(&memory, options);
    for (i = 0; i < count; i++) {
        if (!(fabs(points[i].weight) < HUGE_VAL)) {
            return PBW_ERROR_NOT_FINITE;
        }
    }
    if (!PBW_FIT(&memory, block, (count + 1) * sizeof *points + pbwt_boxes_of(count) * sizeof(pbwt_box))
        || !PBW_FIT(&memory, order, count + 1)) {
        PBW_RELEASE(&memory, block);
        return PBW_ERROR_MEMORY;
    }
    order_options.stride = sizeof *points;
    order_options.memory_limit = pbw_memory_left(&memory);
    status = pbw_order(dim, count > 0 ? points[0].x : NULL, count, &order_options, order.at);
    if (status == PBW_OK) {
        pbwt_point *place;
        making.boxes = (pbwt_box *)(void *)block.at;
        place = (pbwt_point *)(void *)(making.boxes + pbwt_boxes_of(count));
        making.points = place;
        making.count = pbwt__gather(points, order.at, count, place);
        i = (making.count + PBWT_LEAF - 1) / PBWT_LEAF;
        status = pbw_for(&order_options, i, 512, pbwt__lowest_boxes, &making);
    }
    PBW_RELEASE(&memory, order);
    if (status != PBW_OK) {
        PBW_RELEASE(&memory, block);
        return status;
    }
    pbwt__upper_boxes(making.boxes, i);
    tree->dim = dim;
    tree->part = part;
    tree->points = making.points;
    tree->count = making.count;
    tree->boxes = making.boxes;
    tree->box_count = pbwt_boxes_of(making.count);
    pbwt__choose_samples(tree);
    tree->duplicates = count - making.count;
    tree->options = options != NULL ? *options : zero;
    tree->bytes = block.capacity;
    tree->memory = block.at;
    return PBW_OK;
}

/* Makes the room behind the tree's points as large as so many.  Returns it, or NULL without memory. */
static pbwt_point *pbwt__tree_room(pbwt_tree *tree, pbw_memory *memory, size_t extra)
{
    const size_t boxes = (size_t)((const char *)tree->points - (const char *)tree->memory);
    const size_t bytes = boxes + (tree->count + extra + 1) * sizeof(pbwt_point);
    char *block = (char *)pbw_memory_resize(memory, tree->memory, tree->bytes, bytes, 1);
    pbwt_point *points;
    if (block == NULL) {
        return NULL;
    }
    points = (pbwt_point *)(void *)(block + boxes);
    tree->memory = block;
    tree->bytes = bytes;
    tree->boxes = (const pbwt_box *)(void *)block;
    tree->points = points;
    return points + tree->count;
}

/* The memory of a call that has the tree. */
static pbw_memory pbwt__memory_beside(const pbwt_tree *tree)
{
    pbw_memory memory;
    pbw_memory_start(&memory, &tree->options);
    memory.used = tree->bytes;
    return memory;
}

PBWDEF void pbwt_tree_free(pbwt_tree *tree)
{
    pbw_memory memory;
    if (tree->memory != NULL) {
        pbw_memory_start(&memory, &tree->options);
        (void)pbw_memory_resize(&memory, tree->memory, tree->bytes, 0, 1);
    }
    memset(tree, 0, sizeof *tree);
}

PBWDEF void pbwt_summarise(const pbwt_tree *tree, pbwt_summary *summary)
{
    const pbwt__levels levels = pbwt__tree_levels(tree);
    int i;
    memset(summary, 0, sizeof *summary);
    pbwt__box_clear(&summary->box);
    if (levels.levels > 0) {
        summary->box = levels.box[levels.levels - 1][0];
    }
    summary->count = tree->count;
    summary->samples = tree->samples;
    for (i = 0; i < tree->samples; i++) {
        summary->sample[i].point = tree->points[tree->sample[i]];
        summary->sample[i].part = (uint32_t)tree->part;
        summary->sample[i].index = tree->sample[i];
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>balls        Which points and boxes a simplex, or the half-space beyond a facet, may be in conflict with.
   In: a question.  Out: yes, or certainly not.
   Relative to the first corner a, with rows u, v, w to the others, D = det[u v w], h(u) = |u|^2 - (w_b - w_a) and
       N = h(u) v x w + h(v) w x u + h(w) u x v,     F(t) = D (|t|^2 - (w_x - w_a)) - N . t,   t = x - a,
   x is outside if and only if F > 0.  No division: a flat simplex turns into a half-space.  Beyond a facet D is 0
   and N its normal, outward.
   Rounding: each term of F is a product in which every factor and sum has at most 24 relative errors of 2^-53, so
   F is wrong by at most 24 * 1.12e-16 < 1e-14 / 3 times the sum of the absolute values of all terms (Higham 2002,
   Accuracy and Stability, section 3.1, where gamma_24 is this); 1e-14 covers the rounding of that sum and of bounds.
   Underflow and overflow: a ball decides nothing unless each difference of corners is 0 or from 1e-50 to 1e50, so
   that no product of five is out of range; nor do values of F below 1e-250 or above 1e300, or NaN.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwt__question {            /* what travels */
    double x[4][3], weight[4];             /* the corners of a positive simplex */
    uint32_t facet, dim;                   /* facet: 0, or 1 + the corner it is across from: beyond that facet */
    uint32_t weighted, unused;
} pbwt__question;

typedef struct pbwt__ball {
    const pbwt__question *q;
    double a[3], weight, d, d_error, n[3], n_error[3];
    int in_range;                          /* 0: the bounds of rounding do not hold, and nothing is decided */
} pbwt__ball;

#define PBWT__EPSILON 1e-14

static double pbwt__minor(double a, double b, double c, double d, double *size)      /* a d - b c */
{
    *size = fabs(a * d) + fabs(b * c);
    return a * d - b * c;
}

static int pbwt__is_in_range(double x)
{
    return (fabs(x) >= 1e-50 && fabs(x) <= 1e50) || (x <= 0 && x >= 0);
}

/* The cross product, and bounds of its terms. */
static void pbwt__cross(const double *u, const double *v, double *out, double *size)
{
    int k;
    for (k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = pbwt__minor(u[i], u[j], v[i], v[j], size + k);
    }
}

static void pbwt__ball_of_facet(pbwt__ball *ball, const pbwt__question *q)
{
    const int dim = (int)q->dim, apex = (int)q->facet - 1;
    const double turn = apex % 2 != 0 ? -1.0 : 1.0;
    double corner[4][3], u[2][3], n[3], size[3];
    int i, k, count = 0;
    memset(corner, 0, sizeof corner);
    memset(u, 0, sizeof u);
    for (i = 0; i <= dim; i++) {
        if (i != apex) {
            memcpy(corner[count++], q->x[i], sizeof corner[0]);
        }
    }
    memcpy(ball->a, corner[0], sizeof ball->a);
    for (i = 0; i + 1 < dim; i++) {
        for (k = 0; k < 3; k++) {
            u[i][k] = corner[i + 1][k] - corner[0][k];
            ball->in_range &= pbwt__is_in_range(u[i][k]);
        }
    }
    if (dim == 2) {
        n[0] = u[0][1];
        n[1] = -u[0][0];
        n[2] = 0;
        size[0] = fabs(n[0]);
        size[1] = fabs(n[1]);
        size[2] = 0;
    } else {
        pbwt__cross(u[0], u[1], n, size);
    }
    for (k = 0; k < 3; k++) {
        ball->n[k] = turn * n[k];
        ball->n_error[k] = PBWT__EPSILON * size[k];
    }
}

static void pbwt__ball_of(pbwt__ball *ball, const pbwt__question *q)
{
    double u[3][3], h[3], h_size[3], cross[3], size[3];
    int i, k;
    memset(ball, 0, sizeof *ball);
    ball->q = q;
    ball->in_range = 1;
    if (q->facet != 0) {
        pbwt__ball_of_facet(ball, q);
        return;
    }
    memcpy(ball->a, q->x[0], sizeof ball->a);
    ball->weight = q->weight[0];
    memset(u, 0, sizeof u);
    for (i = 0; i < (int)q->dim; i++) {
        for (k = 0; k < 3; k++) {
            u[i][k] = q->x[i + 1][k] - q->x[0][k];
            ball->in_range &= pbwt__is_in_range(u[i][k]);
        }
        ball->in_range &= pbwt__is_in_range(q->weight[i + 1] - q->weight[0]);
        h[i] = u[i][0] * u[i][0] + u[i][1] * u[i][1] + u[i][2] * u[i][2];
        h_size[i] = h[i] + fabs(q->weight[i + 1] - q->weight[0]);
        h[i] -= q->weight[i + 1] - q->weight[0];
    }
    if (q->dim == 2) {                               /* the third row is the unit vector across the plane */
        u[2][2] = 1;
        h[2] = h_size[2] = 0;
    }
    for (i = 0; i < 3; i++) {
        pbwt__cross(u[(i + 1) % 3], u[(i + 2) % 3], cross, size);
        for (k = 0; k < 3; k++) {
            ball->n[k] += h[i] * cross[k];
            ball->n_error[k] += PBWT__EPSILON * h_size[i] * size[k];
            ball->d += i == 0 ? u[0][k] * cross[k] : 0;
            ball->d_error += i == 0 ? PBWT__EPSILON * fabs(u[0][k]) * size[k] : 0;
        }
    }
    if (q->dim == 2) {
        ball->n[2] = ball->n_error[2] = 0;           /* all points are in the plane */
    }
}

/* A box around the ball, for points of weights up to `most`, whatever was rounded.  Returns 0 if the ball is not
   known well enough. */
static int pbwt__around(const pbwt__ball *ball, double most, pbwt_box *box)
{
    const double d = ball->d - ball->d_error;
    double centre[3], radius = most - ball->weight, size = 0;
    int k;
    if (!ball->in_range || !(d > 0.999999 * (ball->d + ball->d_error))) {
        return 0;
    }
    for (k = 0; k < 3; k++) {
        const double error = ball->n_error[k] / (2 * d) + 1e-6 * fabs(ball->n[k] / (2 * d));
        centre[k] = ball->n[k] / (2 * d);
        size = fmax(size, error);
        radius += (fabs(centre[k]) + error) * (fabs(centre[k]) + error);
    }
    radius = (radius > 0 ? sqrt(radius) * (1 + 1e-9) : 0) + size;
    for (k = 0; k < 3; k++) {
        const double x = ball->a[k] + centre[k];
        const double rounding = 1e-15 * (fabs(ball->a[k]) + fabs(centre[k]) + radius);
        box->low[k] = x - radius - rounding;
        box->high[k] = x + radius + rounding;
    }
    box->weight = most;
    return 1;
}

/* A bound from below of d t^2 - n t over [low, high]. */
static double pbwt__parabola(double d, double n, double low, double high)
{
    return 2 * d * low >= n ? (d * low - n) * low : 2 * d * high <= n ? (d * high - n) * high
         : d > 0 ? -n * (n / (4 * d)) : -HUGE_VAL;
}

/* Returns whether F is certainly above 0 for all points of the box. */
static int pbwt__is_clear(const pbwt__ball *ball, const double *low, const double *high, double weight)
{
    const double d_high = ball->d + ball->d_error, lift = weight - ball->weight;
    const double d = ball->d > ball->d_error ? ball->d - ball->d_error : 0;      /* simplices are positive */
    double sum = 0, size = 0;
    int k;
    if (!ball->in_range) {
        return 0;
    }
    for (k = 0; k < 3; k++) {
        const double from = low[k] - ball->a[k], to = high[k] - ball->a[k], n = ball->n[k], e = ball->n_error[k];
        const double away = fabs(from) > fabs(to) ? fabs(from) : fabs(to);
        double least = HUGE_VAL, part;
        if (to >= 0) {
            least = pbwt__parabola(d, n + e, from > 0 ? from : 0, to);
        }
        if (from < 0) {
            part = pbwt__parabola(d, n - e, from, to < 0 ? to : 0);
            least = part < least ? part : least;
        }
        sum += least;
        size += d_high * away * away + fabs(n) * away;
    }
    if (ball->q->facet == 0) {
        sum -= lift > 0 ? d_high * lift : d * lift;
        size += d_high * fabs(lift);
    }
    return sum > PBWT__EPSILON * size && size > 1e-250 && size < 1e300;
}

/* Returns, by exact signs, whether p is in conflict with the simplex, or strictly beyond the facet. */
static int pbwt__conflicts(const pbwt__question *q, const pbwt_point *p)
{
    const double *x[4], *w = NULL;
    double weights[5];
    uint32_t i;
    for (i = 0; i <= q->dim; i++) {
        if (pbwt__same_place(q->x[i], p->x)) {
            return 0;
        }
        x[i] = i + 1 == q->facet ? p->x : q->x[i];
        weights[i] = q->weight[i];
    }
    weights[q->dim + 1] = p->weight;
    w = q->weighted != 0 ? weights : NULL;
    if (q->dim == 2) {
        return q->facet != 0 ? pbw_orient2(x[0], x[1], x[2]) < 0 : pbw_conflict2(x[0], x[1], x[2], p->x, w);
    }
    return q->facet != 0 ? pbw_orient3(x[0], x[1], x[2], x[3]) < 0
         : pbw_conflict3(x[0], x[1], x[2], x[3], p->x, w);
}

/* Returns, by exact signs, whether no corner of the box is in the half-space beyond a facet. */
static int pbwt__corners_clear(const pbwt__question *q, const pbwt_box *box)
{
    pbwt_point corner;
    int i, k;
    memset(&corner, 0, sizeof corner);
    for (i = 0; i < 1 << q->dim; i++) {
        for (k = 0; k < (int)q->dim; k++) {
            corner.x[k] = i >> k & 1 ? box->high[k] : box->low[k];
        }
        if (pbwt__conflicts(q, &corner)) {
            return 0;
        }
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------
   >>walks        The lowest boxes that meet a box or a ball.
   In: levels, a shape.  Out: one such box after the other.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwt__shape { const pbwt_box *box; const pbwt__ball *ball; } pbwt__shape;     /* NULL, or inside */

static int pbwt__is_apart(const pbwt__shape *shape, const double *low, const double *high)
{
    const pbwt_box *box = shape->box;
    return box != NULL && (box->low[0] > high[0] || box->high[0] < low[0] || box->low[1] > high[1]
                           || box->high[1] < low[1] || box->low[2] > high[2] || box->high[2] < low[2]);
}

static int pbwt__meets(const pbwt__shape *shape, const pbwt_box *box)
{
    if (box->low[0] > box->high[0] || pbwt__is_apart(shape, box->low, box->high)) {
        return 0;                                    /* or empty */
    }
    return shape->ball == NULL || !(pbwt__is_clear(shape->ball, box->low, box->high, box->weight)
                                    || (shape->ball->q->facet != 0 && pbwt__corners_clear(shape->ball->q, box)));
}

static int pbwt__has(const pbwt__shape *shape, const pbwt_point *p)
{
    return !pbwt__is_apart(shape, p->x, p->x)
        && (shape->ball == NULL || (!pbwt__is_clear(shape->ball, p->x, p->x, p->weight)
                                    && pbwt__conflicts(shape->ball->q, p)));
}

typedef struct pbwt__node { int level; size_t at; } pbwt__node;
typedef struct pbwt__walk {
    const pbwt__levels *levels;
    const pbwt__shape *shape;
    pbwt__node stack[PBWT__LEVELS * PBWT_ARITY];
    int depth;
    size_t visits;
} pbwt__walk;

static void pbwt__walk_from(pbwt__walk *walk, const pbwt__levels *levels, const pbwt__shape *shape, pbwt__node node)
{
    walk->levels = levels;
    walk->shape = shape;
    walk->depth = levels->levels > 0;
    walk->stack[0] = node;
    walk->visits = 0;
}

static void pbwt__walk_start(pbwt__walk *walk, const pbwt__levels *levels, const pbwt__shape *shape)
{
    pbwt__node root;
    root.level = levels->levels - 1;
    root.at = 0;
    pbwt__walk_from(walk, levels, shape, root);
}

/* Returns the next of the lowest boxes, in ascending order, or (size_t)-1. */
static size_t pbwt__next(pbwt__walk *walk)
{
    while (walk->depth > 0) {
        const pbwt__node node = walk->stack[--walk->depth];
        size_t first, child;
        walk->visits++;
        if (!pbwt__meets(walk->shape, walk->levels->box[node.level] + node.at)) {
            continue;
        }
        if (node.level == 0) {
            return node.at;
        }
        first = pbwt__below(walk->levels, node.level, node.at, &child);
        while (child-- > first) {
            walk->stack[walk->depth].level = node.level - 1;
            walk->stack[walk->depth++].at = child;
        }
    }
    return (size_t)-1;
}

/* ------------------------------------------------------------------------------------------------------
   >>answers      The points that another part asks for.
   In: a request: a head, then boxes of the halo or questions.  Out: a reply: a head, a verdict for each (a byte,
   filled up to 8), then points that were not sent before.
   Holds: after the verdict PBWT__ALL the part that asked has all points in conflict; after PBWT__SOME at least one.
   ------------------------------------------------------------------------------------------------------ */
enum { PBWT__NOTHING, PBWT__ALL, PBWT__SOME, PBWT__REFUSED, PBWT__OPEN };        /* verdicts; OPEN: not yet */
enum { PBWT__WANT = 0x77746270, PBWT__ASK, PBWT__REPLY };               /* kinds of messages */

/* points: in a reply, how many; in a request, whether the samples of the part asked are known. */
typedef struct pbwt__head { uint32_t kind, count; uint64_t points; } pbwt__head;

typedef struct pbwt__serving {
    const pbwt_tree *tree;
    pbwt_served *served;
    pbw_memory memory;
    pbwt__levels levels;
    pbwt__numbers set, found;                        /* set: a hash table of index + 1 */
    pbwt__vertices out;
    size_t most, few;                                /* points in an answer, and if there are more */
    size_t work, points;                             /* most visits, and points in a reply */
    int samples;                                     /* known: never sent */
} pbwt__serving;

static size_t pbwt__slot(const pbwt__numbers *set, uint32_t index)       /* where it is or would be */
{
    const size_t mask = set->capacity - 1;
    size_t at = (index * (size_t)0x9e3779b1u >> 7) & mask;
    while (set->at[at] != 0 && set->at[at] != index + 1) {
        at = (at + 1) & mask;
    }
    return at;
}

/* Sizes are powers of two, at most half full. */
static int pbwt__grow_set(pbwt__serving *s)
{
    pbwt__numbers larger = { NULL, 0, 0 };
    size_t i;
    if (2 * (s->served->sent + 1) <= s->set.capacity) {
        return 1;
    }
    if (!PBW_ZEROS(&s->memory, larger, s->set.capacity > 0 ? 2 * s->set.capacity : 1024)) {
        return 0;
    }
    for (i = 0; i < s->set.capacity; i++) {
        if (s->set.at[i] != 0) {
            larger.at[pbwt__slot(&larger, s->set.at[i] - 1)] = s->set.at[i];
        }
    }
    PBW_RELEASE(&s->memory, s->set);
    s->set = larger;
    return 1;
}

static int pbwt__send(pbwt__serving *s, uint32_t index)      /* unless it was sent; returns 0 without memory */
{
    pbwt_vertex vertex;
    size_t at;
    int i;
    for (i = 0; i < s->samples; i++) {
        if (s->tree->sample[i] == index) {
            return 1;
        }
    }
    if (!pbwt__grow_set(s)) {
        return 0;
    }
    at = pbwt__slot(&s->set, index);
    if (s->set.at[at] != 0) {
        return 1;
    }
    s->set.at[at] = index + 1;
    s->served->sent++;
    vertex.point = s->tree->points[index];
    vertex.part = (uint32_t)s->tree->part;
    vertex.index = index;
    return PBW_PUSH(&s->memory, s->out, vertex);
}

/* Finds points of the shape below a node, up to `most`.  Returns 0 without memory. */
static int pbwt__collect(pbwt__serving *s, const pbwt__shape *shape, pbwt__node node, size_t most)
{
    pbwt__walk walk;
    size_t leaf, i;
    pbwt__walk_from(&walk, &s->levels, shape, node);
    while (s->found.count < most && (leaf = pbwt__next(&walk)) != (size_t)-1) {
        const size_t left = s->tree->count - leaf * PBWT_LEAF;
        pbwt__need(s->tree, s->tree->points + leaf * PBWT_LEAF,
                   (left < PBWT_LEAF ? left : PBWT_LEAF) * sizeof(pbwt_point));
        for (i = leaf * PBWT_LEAF; i < (leaf + 1) * PBWT_LEAF && i < s->tree->count && s->found.count < most; i++) {
            const uint32_t index = (uint32_t)i;
            if (pbwt__has(shape, s->tree->points + i) && !PBW_PUSH(&s->memory, s->found, index)) {
                return 0;
            }
        }
        walk.visits += PBWT_LEAF / 4;
    }
    s->served->visits += walk.visits;
    return 1;
}

/* Finds one point of the shape in each of some boxes that cover it: not more boxes than `few` times the arity. */
static int pbwt__spread(pbwt__serving *s, const pbwt__shape *shape)
{
    pbwt__node front[2][96 * PBWT_ARITY];
    size_t count = 1, i, step;
    int level = s->levels.levels - 1, now = 0;
    front[0][0].level = level;
    front[0][0].at = 0;
    s->found.count = 0;
    while (level > 0 && count < s->few) {
        size_t next = 0, child, end;
        level--;
        for (i = 0; i < count; i++) {
            for (child = pbwt__below(&s->levels, level + 1, front[now][i].at, &end); child < end; child++) {
                if (pbwt__meets(shape, s->levels.box[level] + child)) {
                    front[!now][next].level = level;
                    front[!now][next++].at = child;
                }
            }
        }
        now = !now;
        count = next;
    }
    step = count > s->few ? count / s->few : 1;
    for (i = 0; i < count && s->found.count < s->few; i++) {
        const size_t before = s->found.count;
        if (!pbwt__collect(s, shape, front[now][i], before + 1)) {
            return 0;
        }
        i += s->found.count > before ? step - 1 : 0;
    }
    return 1;
}

/* The points of one shape.  Returns the verdict, or -1 without memory. */
static int pbwt__answer_one(pbwt__serving *s, const pbwt__shape *shape)
{
    pbwt__node root;
    int verdict = PBWT__ALL;
    size_t i;
    root.level = s->levels.levels - 1;
    root.at = 0;
    s->found.count = 0;
    if (!pbwt__collect(s, shape, root, s->most + 1)) {
        return -1;
    }
    if (s->found.count == 0) {
        return PBWT__NOTHING;
    }
    if (s->found.count > s->most) {
        verdict = PBWT__SOME;
        if (!pbwt__spread(s, shape)) {
            return -1;
        }
    }
    for (i = 0; i < s->found.count; i++) {
        if (!pbwt__send(s, s->found.at[i])) {
            return -1;
        }
    }
    return verdict;
}

static int pbwt__answer_record(pbwt__serving *s, int kind, const char *record)
{
    pbwt__question question;
    pbwt__ball ball;
    pbwt__shape shape;
    pbwt_box box;
    if (kind == PBWT__WANT) {
        memcpy(&box, record, sizeof box);
        shape.box = &box;
        shape.ball = NULL;
    } else {
        memcpy(&question, record, sizeof question);
        if (question.dim != (uint32_t)s->tree->dim || question.facet > question.dim + 1) {
            return PBWT__REFUSED;
        }
        pbwt__ball_of(&ball, &question);
        shape.ball = &ball;
        shape.box = s->levels.levels > 0 && pbwt__around(&ball, s->levels.box[s->levels.levels - 1]->weight, &box)
                  ? &box : NULL;
    }
    return pbwt__answer_one(s, &shape);
}

static pbw_status pbwt__write_reply(pbwt__serving *s, const pbwt__bytes *verdicts, pbwt_bytes *reply)
{
    const size_t bytes = (verdicts->count + 7) / 8 * 8, points = s->out.count * sizeof(pbwt_vertex);
    pbwt__head head;
    char *text = (char *)pbw_memory_resize(&s->memory, NULL, 0, sizeof head + bytes + points, 1);
    if (text == NULL) {
        return PBW_ERROR_MEMORY;
    }
    head.kind = PBWT__REPLY;
    head.count = (uint32_t)verdicts->count;
    head.points = s->out.count;
    memcpy(text, &head, sizeof head);
    memset(text + sizeof head, 0, bytes);
    memcpy(text + sizeof head, verdicts->at, verdicts->count);
    if (points > 0) {
        memcpy(text + sizeof head + bytes, s->out.at, points);
    }
    reply->data = text;
    reply->size = sizeof head + bytes + points;
    return PBW_OK;
}

PBWDEF void pbwt_bytes_free(const pbwt_tree *tree, pbwt_bytes *bytes)
{
    pbw_memory memory;
    if (bytes->data != NULL) {
        pbw_memory_start(&memory, &tree->options);
        (void)pbw_memory_resize(&memory, bytes->data, bytes->size, 0, 1);
    }
    memset(bytes, 0, sizeof *bytes);
}

PBWDEF void pbwt_served_free(const pbwt_tree *tree, pbwt_served *served)
{
    pbwt_bytes_free(tree, &served->set);
    memset(served, 0, sizeof *served);
}

/* Answers every `step`-th record that has no verdict yet, within limits of visits and points.  Returns 0 without
   memory. */
static int pbwt__answer_every(pbwt__serving *s, const pbwt_bytes *request, size_t step, pbwt__bytes *verdicts)
{
    pbwt__head head;
    size_t i, size;
    memcpy(&head, request->data, sizeof head);
    size = head.kind == PBWT__WANT ? sizeof(pbwt_box) : sizeof(pbwt__question);
    for (i = 0; i < head.count; i += step) {
        int verdict = PBWT__REFUSED;
        if (verdicts->at[i] != PBWT__OPEN) {
            continue;
        }
        if (head.kind == PBWT__WANT || (s->served->visits <= s->work && s->out.count <= s->points)) {
            verdict = pbwt__answer_record(s, (int)head.kind, request->data + sizeof head + i * size);
        }
        if (verdict < 0) {
            return 0;
        }
        verdicts->at[i] = (unsigned char)verdict;
    }
    return 1;
}

/* If there are many questions, answers a sample first.  If by this sample half of all would have to be refused,
   nearly every star would have a refused one, so all others are refused. */
static pbw_status pbwt__answer_all(pbwt__serving *s, const pbwt_bytes *request, const pbwt_limits *limits,
                                   uint64_t asker, pbwt__bytes *verdicts)
{
    const size_t before = s->served->visits;
    pbwt__head head;
    size_t size, step;
    if (request->size < sizeof head) {
        return PBW_ERROR_ARGUMENT;
    }
    memcpy(&head, request->data, sizeof head);
    size = head.kind == PBWT__WANT ? sizeof(pbwt_box) : sizeof(pbwt__question);
    if ((head.kind != PBWT__WANT && head.kind != PBWT__ASK) || request->size != sizeof head + head.count * size) {
        return PBW_ERROR_ARGUMENT;
    }
    s->work = (limits->work > 0 ? limits->work : 20) * (size_t)(asker + 5000);
    s->points = limits->points > 0 ? limits->points : (size_t)asker / 2 + 1000;
    s->most = head.kind == PBWT__WANT ? (limits->halo_answer > 0 ? limits->halo_answer : 512)
            : limits->answer > 0 ? limits->answer : 64;
    s->few = head.kind == PBWT__WANT ? 64 : (s->most + 2) / 3;
    s->samples = head.points != 0 ? s->tree->samples : 0;
    s->few = s->few > 64 ? 64 : s->few > s->most ? s->most : s->few;
    if (!PBW_ZEROS(&s->memory, *verdicts, head.count)) {
        return PBW_ERROR_MEMORY;
    }
    memset(verdicts->at, PBWT__OPEN, head.count);
    step = head.kind == PBWT__ASK ? head.count / 256 : 0;
    if (step > 16) {
        if (!pbwt__answer_every(s, request, step, verdicts)) {
            return PBW_ERROR_MEMORY;
        }
        if ((double)before + (double)(s->served->visits - before) * (double)step > 2 * (double)s->work) {
            s->work = 0;
        }
    }
    return pbwt__answer_every(s, request, 1, verdicts) ? PBW_OK : PBW_ERROR_MEMORY;
}

PBWDEF pbw_status pbwt_answer(const pbwt_tree *tree, pbwt_served *served, const pbwt_bytes *request,
                              const pbwt_limits *limits, uint64_t asker, pbwt_bytes *reply)
{
    pbwt__serving s;
    pbwt__bytes verdicts = { NULL, 0, 0 };
    pbwt_limits defaults;
    pbw_status status;
    memset(&s, 0, sizeof s);
    memset(&defaults, 0, sizeof defaults);
    s.tree = tree;
    s.served = served;
    s.memory = pbwt__memory_beside(tree);
    s.memory.used += served->set.size;
    s.levels = pbwt__tree_levels(tree);
    if (s.levels.levels > 0) {
        pbwt__need(tree, s.levels.box[s.levels.levels - 1], sizeof(pbwt_box));
    }
    s.set.at = (uint32_t *)(void *)served->set.data;
    s.set.capacity = served->set.size / sizeof(uint32_t);
    pbwt_bytes_free(tree, reply);
    status = pbwt__answer_all(&s, request, limits != NULL ? limits : &defaults, asker, &verdicts);
    if (status == PBW_OK) {
        status = pbwt__write_reply(&s, &verdicts, reply);
    }
    served->set.data = (char *)s.set.at;
    served->set.size = s.set.capacity * sizeof(uint32_t);
    PBW_RELEASE(&s.memory, s.out);
    PBW_RELEASE(&s.memory, s.found);
    PBW_RELEASE(&s.memory, verdicts);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>tile         One part's state; its requests, and the replies.
   In: summaries of all parts; replies.  Out: a request for each part.
   Holds: local numbers below `own` are points of the tree, those from there on are foreign points.
   A level is a mesh and its subjects, own vertices with complete stars in it.
     1. The first mesh is of all local points; the next ones are of the points that a repair needs, fewer each time.
     2. After each round of questions, subjects without a point in conflict are final: their simplices are emitted.
     3. The repair of the others replaces the level.
   ------------------------------------------------------------------------------------------------------ */
/* States of own vertices: emitted; final in this level; to be certified; with points in conflict, all known or only
   some; given up. */
enum { PBWT__DONE, PBWT__SUBJECT, PBWT__ASKED, PBWT__AFFECTED, PBWT__MORE, PBWT__GIVEN };

typedef struct pbwt__level {
    pbw_mesh mesh;
    size_t bytes;                                    /* of the mesh, in the tile's memory.used */
    pbwt__numbers map;                               /* per point of the mesh: its local number; none: the same */
} pbwt__level;

struct pbwt__tile {
    pbwt_options options;
    pbw_memory memory;                               /* used: the tree and the level's mesh included */
    pbwt_tile *tile;
    size_t own;                                      /* points of the tree: local numbers below are own ones */
    int stage;                                       /* calls of pbwt_ask */
    PBW_ARRAY(pbwt_box) parts;                       /* the hierarchy over the boxes of all parts */
    pbwt__bytes known;                               /* per part, a byte: its samples are foreign points */
    pbwt__levels levels;
    double foreign_weight;                           /* the largest elsewhere */
    PBW_ARRAY(pbwt__bytes) request;                  /* per part */
    PBW_ARRAY(pbwt__numbers) asked;                  /* per part: what the records of the request are about */
    pbwt__vertices foreign;
    pbwt__bytes state;                               /* per own vertex */
    PBW_ARRAY(double) held;                          /* per leaf, how far around it all points are known */
    pbwt__facets facets;
    pbwt__numbers given;                             /* own vertices given up */
    pbwt__numbers border;                            /* corners of final simplices that have others, too */
    size_t before;                                   /* foreign points before the last replies */
    pbwt__level level;
    pbwt__bytes mark;                                /* per simplex, or per point */
    pbwt__numbers queue;                             /* of simplices */
};

static int pbwt__corners(const struct pbwt__tile *t)
{
    return t->tile->dim + 1;
}

static uint32_t pbwt__local(const struct pbwt__tile *t, pbw_index vertex)       /* of a point of the level's mesh */
{
    return t->level.map.at != NULL ? t->level.map.at[vertex] : vertex;
}

static int pbwt__state(const struct pbwt__tile *t, uint32_t local)               /* of foreign points: DONE */
{
    return local < t->own ? (int)t->state.at[local] : (int)PBWT__DONE;
}

static const pbwt_point *pbwt__point(const struct pbwt__tile *t, uint32_t local)
{
    return local < t->own ? t->tile->tree->points + local
         : &t->foreign.at[local - t->own].point;
}

static pbw_options pbwt__inner_options(const struct pbwt__tile *t)               /* with the memory that is left */
{
    pbw_options options = t->options.build;
    options.stride = options.weight_stride = 0;
    options.trace = NULL;
    options.memory_limit = pbw_memory_left(&t->memory);
    return options;
}

static void pbwt__level_free(struct pbwt__tile *t, pbwt__level *level)
{
    pbw_free(&level->mesh);
    t->memory.used -= level->bytes;
    level->bytes = 0;
    PBW_RELEASE(&t->memory, level->map);
}

PBWDEF void pbwt_close(pbwt_tile *tile)
{
    struct pbwt__tile *t = tile->memory;
    pbw_memory memory;
    int p;
    if (t == NULL) {
        memset(tile, 0, sizeof *tile);
        return;
    }
    memory = t->memory;
    for (p = 0; p < tile->parts && t->request.at != NULL; p++) {
        PBW_RELEASE(&t->memory, t->request.at[p]);
    }
    for (p = 0; p < tile->parts && t->asked.at != NULL; p++) {
        PBW_RELEASE(&t->memory, t->asked.at[p]);
    }
    pbwt__level_free(t, &t->level);
    PBW_RELEASE(&t->memory, t->parts);
    PBW_RELEASE(&t->memory, t->known);
    PBW_RELEASE(&t->memory, t->request);
    PBW_RELEASE(&t->memory, t->asked);
    PBW_RELEASE(&t->memory, t->foreign);
    PBW_RELEASE(&t->memory, t->state);
    PBW_RELEASE(&t->memory, t->held);
    PBW_RELEASE(&t->memory, t->facets);
    PBW_RELEASE(&t->memory, t->given);
    PBW_RELEASE(&t->memory, t->border);
    PBW_RELEASE(&t->memory, t->mark);
    PBW_RELEASE(&t->memory, t->queue);
    (void)pbw_memory_resize(&memory, t, 1, 0, sizeof *t);
    (void)pbw_memory_resize(&memory, tile->request, (size_t)tile->parts, 0, sizeof *tile->request);
    memset(tile, 0, sizeof *tile);
}

static int pbwt__allocate_tile(pbwt_tile *tile, const pbwt_options *options)
{
    const size_t parts = (size_t)tile->parts;        /* 0 of pbwt_finish: no requests */
    pbw_memory memory;
    pbw_memory_start(&memory, &options->build);
    tile->request = (pbwt_bytes *)pbw_memory_resize(&memory, NULL, 0, parts, sizeof *tile->request);
    if (tile->request == NULL && parts > 0) {
        return 0;
    }
    tile->memory = (struct pbwt__tile *)pbw_memory_resize(&memory, NULL, 0, 1, sizeof *tile->memory);
    if (tile->memory == NULL) {
        (void)pbw_memory_resize(&memory, tile->request, parts, 0, sizeof *tile->request);
        return 0;
    }
    if (parts > 0) {
        memset(tile->request, 0, parts * sizeof *tile->request);
    }
    memset(tile->memory, 0, sizeof *tile->memory);
    tile->memory->options = *options;
    tile->memory->memory = memory;
    tile->memory->tile = tile;
    return 1;
}

/* Returns whether to take the samples of a part: of many parts, only near ones, those at the ends of each axis, and
   every n-th one. */
static int pbwt__takes_samples(const struct pbwt__tile *t, const pbwt_summary *summaries, size_t p)
{
    const size_t parts = (size_t)t->tile->parts;
    const pbwt_box *own = &summaries[t->tile->tree->part].box, *box = &summaries[p].box;
    const pbwt_box *all = t->parts.at + t->parts.count - 1;
    int k, nearby = 1, end = 0;
    for (k = 0; k < t->tile->dim; k++) {
        const double size = own->high[k] - own->low[k];
        nearby &= box->low[k] <= own->high[k] + size && box->high[k] >= own->low[k] - size;
        end |= !(box->low[k] > all->low[k]) || !(box->high[k] < all->high[k]);
    }
    return parts <= 64 || nearby || p % (parts / 32) == 0 || (end && p % (parts / 32) < 2);
}

/* Copies the summaries: boxes of the other parts, and samples as the first foreign points. */
static pbw_status pbwt__meet_parts(struct pbwt__tile *t, const pbwt_summary *summaries)
{
    const size_t parts = (size_t)t->tile->parts;
    pbwt_box *box;
    size_t p;
    int i;
    if (!PBW_ZEROS(&t->memory, t->parts, pbwt__level_boxes(parts))
        || !PBW_ZEROS(&t->memory, t->known, parts)
        || !PBW_ZEROS(&t->memory, t->request, parts)
        || !PBW_ZEROS(&t->memory, t->asked, parts)) {
        return PBW_ERROR_MEMORY;
    }
    box = t->parts.at;
    t->foreign_weight = -HUGE_VAL;
    for (p = 0; p < parts; p++) {
        box[p] = summaries[p].box;
        if ((int)p == t->tile->tree->part) {
            pbwt__box_clear(box + p);
            continue;
        }
        t->foreign_weight = box[p].weight > t->foreign_weight ? box[p].weight : t->foreign_weight;
    }
    pbwt__upper_boxes(box, parts);
    t->levels = pbwt__levels_over(box, parts);
    for (p = 0; p < parts; p++) {
        if ((int)p == t->tile->tree->part || !pbwt__takes_samples(t, summaries, p)) {
            continue;
        }
        t->known.at[p] = 1;
        for (i = 0; i < summaries[p].samples; i++) {
            if (!PBW_PUSH(&t->memory, t->foreign, summaries[p].sample[i])) {
                return PBW_ERROR_MEMORY;
            }
        }
    }
    return PBW_OK;
}

PBWDEF pbw_status pbwt_open(pbwt_tile *tile, pbwt_tree *tree, const pbwt_summary *summaries, int parts,
                            const pbwt_options *options)
{
    pbwt_options defaults;
    pbw_status status = PBW_OK;
    memset(tile, 0, sizeof *tile);
    memset(&defaults, 0, sizeof defaults);
    options = options != NULL ? options : &defaults;
    if (tree->dim < 2 || tree->dim > 3 || parts < 1 || tree->part < 0 || tree->part >= parts) {
        return PBW_ERROR_ARGUMENT;
    }
    tile->dim = tree->dim;
    tile->parts = parts;
    tile->tree = tree;
    if (!pbwt__allocate_tile(tile, options)) {
        memset(tile, 0, sizeof *tile);
        return PBW_ERROR_MEMORY;
    }
    tile->memory->own = tree->count;
    tile->memory->memory.used += tree->bytes;
    status = pbwt__meet_parts(tile->memory, summaries);
    if (status == PBW_OK
        && (!PBW_ZEROS(&tile->memory->memory, tile->memory->state, tree->count)
            || !PBW_ZEROS(&tile->memory->memory, tile->memory->held, tree->count / PBWT_LEAF + 1))) {
        status = PBW_ERROR_MEMORY;
    }
    if (status != PBW_OK) {
        pbwt_close(tile);
    } else {
        memset(tile->memory->state.at, PBWT__ASKED, tree->count);
    }
    return status;
}

/* ---- requests */

static void pbwt__drop_requests(struct pbwt__tile *t)
{
    int p;
    for (p = 0; p < t->tile->parts; p++) {
        PBW_RELEASE(&t->memory, t->request.at[p]);
        PBW_RELEASE(&t->memory, t->asked.at[p]);
        t->tile->request[p].data = NULL;
        t->tile->request[p].size = 0;
    }
}

/* Appends a record to the request for a part, and notes what it is about. */
static int pbwt__request(struct pbwt__tile *t, size_t part, const void *record, size_t size, uint32_t about)
{
    pbwt__bytes *request = t->request.at + part;
    const size_t head = request->count == 0 ? sizeof(pbwt__head) : 0;
    if (!PBW_RESERVE(&t->memory, *request, head + size) || !PBW_PUSH(&t->memory, t->asked.at[part], about)) {
        return 0;
    }
    memset(request->at + request->count, 0, head);   /* filled in the end */
    memcpy(request->at + request->count + head, record, size);
    request->count += head + size;
    return 1;
}

/* Returns whether there are any. */
static int pbwt__end_requests(struct pbwt__tile *t, uint32_t kind)
{
    int p, any = 0;
    for (p = 0; p < t->tile->parts; p++) {
        pbwt__bytes *request = t->request.at + p;
        pbwt__head head;
        if (request->count > 0) {
            memset(&head, 0, sizeof head);
            head.kind = kind;
            head.count = (uint32_t)t->asked.at[p].count;
            head.points = t->known.at[p];
            memcpy(request->at, &head, sizeof head);
            t->tile->request[p].data = (char *)request->at;
            t->tile->request[p].size = request->count;
            t->tile->numbers.sent_bytes += request->count;
            any = 1;
        }
    }
    return any;
}

/* The spacing of points in a leaf: in space, or if the leaf is flatter than that, in a plane, or on a line. */
static double pbwt__spacing(const pbwt_box *box, size_t count)
{
    double side[3], swap;
    int k;
    for (k = 0; k < 3; k++) {
        side[k] = box->high[k] - box->low[k];
    }
    for (k = 0; k < 3; k++) {                        /* 0 1, 1 2, 0 1: descending */
        if (side[k % 2] < side[k % 2 + 1]) {
            swap = side[k % 2];
            side[k % 2] = side[k % 2 + 1];
            side[k % 2 + 1] = swap;
        }
    }
    return fmax(cbrt(side[0] * side[1] * side[2] / (double)count),
                fmax(sqrt(side[0] * side[1] / (double)count), side[0] / (double)count));
}

/* Asks for the points around each leaf near other parts. */
static pbw_status pbwt__want_halo(struct pbwt__tile *t)
{
    const pbwt_tree *tree = t->tile->tree;
    const double wide = t->options.halo > 0 ? t->options.halo : t->options.halo < 0 ? 0 : 1.5;
    double *held = t->held.at;
    size_t leaf, part;
    int k;
    for (leaf = 0; leaf * PBWT_LEAF < tree->count; leaf++) {
        const size_t rest = tree->count - leaf * PBWT_LEAF;
        pbwt_box box = tree->boxes[leaf];
        const double h = wide * pbwt__spacing(&box, rest < PBWT_LEAF ? rest : PBWT_LEAF);
        pbwt__shape shape;
        pbwt__walk walk;
        held[leaf] = h;
        if (!(h > 0 && h < HUGE_VAL)) {
            held[leaf] = -1;
            continue;
        }
        for (k = 0; k < tree->dim; k++) {
            box.low[k] -= h;
            box.high[k] += h;
        }
        shape.box = &box;
        shape.ball = NULL;
        pbwt__walk_start(&walk, &t->levels, &shape);
        while ((part = pbwt__next(&walk)) != (size_t)-1) {
            if (!pbwt__request(t, part, &box, sizeof box, (uint32_t)leaf)) {
                return PBW_ERROR_MEMORY;
            }
        }
    }
    return PBW_OK;
}

/* ---- replies */

/* A verdict on a simplex of the level, or on one of its facets. */
static void pbwt__hear(struct pbwt__tile *t, uint32_t simplex, int verdict)
{
    const int state = verdict == PBWT__ALL ? PBWT__AFFECTED : verdict == PBWT__SOME ? PBWT__MORE : PBWT__GIVEN;
    const pbw_index *corner = t->level.mesh.simplices + (size_t)simplex * (size_t)pbwt__corners(t);
    int k;
    t->tile->numbers.answered += verdict != PBWT__REFUSED;
    for (k = 0; k < pbwt__corners(t); k++) {
        const uint32_t v = pbwt__local(t, corner[k]);
        const int now = pbwt__state(t, v);
        if (now >= PBWT__ASKED && state > now) {
            t->state.at[v] = (unsigned char)state;
        }
    }
}

PBWDEF pbw_status pbwt_take(pbwt_tile *tile, int part, const void *reply, size_t size)
{
    struct pbwt__tile *t = tile->memory;
    const pbwt__numbers *asked;
    const char *text = (const char *)reply;
    pbwt__head head;
    size_t bytes, i;
    if (t == NULL || part < 0 || part >= tile->parts || size < sizeof head) {
        return PBW_ERROR_ARGUMENT;
    }
    asked = t->asked.at + part;
    memcpy(&head, reply, sizeof head);
    bytes = ((size_t)head.count + 7) / 8 * 8;
    if (head.kind != PBWT__REPLY || head.count != asked->count || head.points > size / sizeof(pbwt_vertex)
        || size != sizeof head + bytes + head.points * sizeof(pbwt_vertex)) {
        return PBW_ERROR_ARGUMENT;
    }
    for (i = 0; i < head.count; i++) {
        const int verdict = text[sizeof head + i];
        const uint32_t about = asked->at[i];
        if (t->stage == 1 && verdict >= PBWT__SOME) {
            t->held.at[about] = -1;
        } else if (t->stage > 1 && verdict != PBWT__NOTHING) {
            pbwt__hear(t, about, verdict);
        }
    }
    if (!PBW_RESERVE(&t->memory, t->foreign, (size_t)head.points)) {
        return PBW_ERROR_MEMORY;
    }
    if (head.points > 0) {
        memcpy(t->foreign.at + t->foreign.count, text + sizeof head + bytes,
               (size_t)head.points * sizeof(pbwt_vertex));
    }
    t->foreign.count += (size_t)head.points;
    tile->foreign = t->foreign.at;
    tile->foreign_count = t->foreign.count;
    tile->numbers.sent_bytes += size;
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>levels       Meshes, and which of their simplices are certain.
   In: the local points of a level.  Out: their mesh; questions about simplices that a foreign point may be in
   conflict with.
   Holds: a simplex that was not reached from the hull or a foreign corner, through simplices in doubt, is certain.
   ------------------------------------------------------------------------------------------------------ */

/* At least what a mesh that owns its points holds: corners, links; coordinates, weights, incident, canonical; and
   some for its parts of other sizes. */
static size_t pbwt__mesh_bytes(const pbw_mesh *mesh)
{
    const size_t dim = (size_t)mesh->dim, weights = mesh->weights != NULL;
    return 2 * mesh->simplex_count * (dim + 1) * sizeof(pbw_index)
         + mesh->point_count * ((dim + weights) * sizeof(double) + 2 * sizeof(pbw_index)) + 1024;
}

/* Triangulates count points, `stride` bytes apart; a degenerate level has no simplices. */
static pbw_status pbwt__build(struct pbwt__tile *t, const double *x, const double *weight, size_t count,
                              size_t stride)
{
    pbw_options options = pbwt__inner_options(t);
    pbw_status status;
    if (count > 0xfffffff0u) {
        return PBW_ERROR_TOO_LARGE;
    }
    options.stride = options.weight_stride = stride;
    options.flags &= ~(PBW_NO_NEIGHBORS | PBW_CURVE_ORDER | PBW_BORROW);
    status = pbw_triangulate(t->tile->dim, x, t->options.weighted ? weight : NULL, count, &options,
                             &t->level.mesh);
    t->level.bytes = t->level.mesh.memory != NULL ? pbwt__mesh_bytes(&t->level.mesh) : 0;
    t->memory.used += t->level.bytes;
    return status == PBW_DEGENERATE ? PBW_OK : status;
}

/* Triangulates the points of the level's map, or all: copies of what a build reads of them. */
static pbw_status pbwt__triangulate(struct pbwt__tile *t, size_t count)
{
    const size_t dim = (size_t)t->tile->dim, entries = dim + (t->options.weighted != 0);
    PBW_ARRAY(double) copy = { NULL, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i;
    if (PBW_FIT(&t->memory, copy, (count + 1) * entries)) {
        double *to = copy.at;
        for (i = 0; i < count; i++, to += entries) {
            const pbwt_point *p = pbwt__point(t, pbwt__local(t, (pbw_index)i));
            memcpy(to, p->x, dim * sizeof *to);
            to[entries - 1] = t->options.weighted ? p->weight : p->x[dim - 1];
        }
        to = copy.at;
        status = pbwt__build(t, to, to + dim, count, entries * sizeof *to);
    }
    PBW_RELEASE(&t->memory, copy);
    return status;
}

/* Triangulates all points; the halo's are appended to those of the tree meanwhile. */
static pbw_status pbwt__triangulate_in_place(struct pbwt__tile *t)
{
    pbwt_tree *tree = t->tile->tree;
    pbw_memory memory;
    pbwt_point *room;
    pbw_status status;
    size_t i;
    pbw_memory_start(&memory, &tree->options);
    memory.limit = t->memory.limit;
    memory.used = t->memory.used;
    room = pbwt__tree_room(tree, &memory, t->foreign.count);
    t->memory.used = memory.used;
    if (room == NULL) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < t->foreign.count; i++) {
        room[i] = t->foreign.at[i].point;
    }
    status = pbwt__build(t, tree->points->x, &tree->points->weight, t->own + t->foreign.count, sizeof *room);
    memory.used = t->memory.used;
    (void)pbwt__tree_room(tree, &memory, 0);         /* what cannot be given back stays */
    t->memory.used = memory.used;
    return status;
}

static void pbwt__question_of(const struct pbwt__tile *t, uint32_t simplex, int facet, pbwt__question *q)
{
    const pbw_index *corner = t->level.mesh.simplices + (size_t)simplex * (size_t)pbwt__corners(t);
    int k;
    memset(q, 0, sizeof *q);
    for (k = 0; k < pbwt__corners(t); k++) {
        const pbwt_point *p = pbwt__point(t, pbwt__local(t, corner[k]));
        memcpy(q->x[k], p->x, sizeof q->x[k]);
        q->weight[k] = p->weight;
    }
    q->facet = (uint32_t)facet;
    q->dim = (uint32_t)t->tile->dim;
    q->weighted = (uint32_t)t->options.weighted;
}

/* Returns whether the box around a ball is inside the grown box of a leaf with an own corner: all points there are
   known. */
static int pbwt__is_held(const struct pbwt__tile *t, uint32_t simplex, const pbwt_box *around)
{
    const pbw_index *corner = t->level.mesh.simplices + (size_t)simplex * (size_t)pbwt__corners(t);
    int i, k;
    for (i = 0; i < pbwt__corners(t); i++) {
        const uint32_t v = pbwt__local(t, corner[i]), leaf = v / PBWT_LEAF;
        int inside = v < t->own && t->held.at[leaf] >= 0;
        for (k = 0; k < t->tile->dim && inside; k++) {
            const double h = t->held.at[leaf] * (1 - 1e-9);
            inside &= around->low[k] >= t->tile->tree->boxes[leaf].low[k] - h
                   && around->high[k] <= t->tile->tree->boxes[leaf].high[k] + h;
        }
        if (inside) {
            return 1;
        }
    }
    return 0;
}

/* Certification goes in waves over lists of simplices; threads test ranges of one, each into a list of its own. */
typedef struct pbwt__doubt { uint32_t simplex, facet, part; } pbwt__doubt;       /* a question, and the part to ask */

typedef PBW_ARRAY(pbwt__doubt) pbwt__doubts;

typedef struct pbwt__certifying {
    struct pbwt__tile *t;
    const uint32_t *wave;
    pbwt__doubts *doubts;                            /* per range */
    size_t tested;                                   /* by all threads */
} pbwt__certifying;

enum { PBWT__RANGE = 1024, PBWT__WAVE = 16 * PBWT__RANGE, PBWT__SCAN = 65536 };      /* simplices */

/* Lists the parts that may have points in conflict with a simplex (facet 0) or beyond a facet of it.  Returns 0
   without memory. */
static int pbwt__inquire(struct pbwt__tile *t, uint32_t simplex, int facet, pbwt__doubts *doubts)
{
    pbwt__question q;
    pbwt__ball ball;
    pbwt__shape shape;
    pbwt__walk walk;
    pbwt_box around;
    size_t part;
    pbwt__question_of(t, simplex, facet, &q);
    pbwt__ball_of(&ball, &q);
    shape.ball = &ball;
    shape.box = pbwt__around(&ball, t->foreign_weight, &around) ? &around : NULL;
    if (shape.box != NULL && pbwt__is_held(t, simplex, &around)) {
        return 1;
    }
    pbwt__walk_start(&walk, &t->levels, &shape);
    while ((part = pbwt__next(&walk)) != (size_t)-1) {
        pbwt__doubt doubt;
        doubt.simplex = simplex;
        doubt.facet = (uint32_t)facet;
        doubt.part = (uint32_t)part;
        if (!PBW_PUSH(&t->memory, *doubts, doubt)) {
            return 0;
        }
    }
    return 1;
}

/* Tests simplices, and the facets of the hull that they have. */
static pbw_status pbwt__test_range(void *arg, size_t from, size_t to)
{
    pbwt__certifying *c = (pbwt__certifying *)arg;
    struct pbwt__tile *t = c->t;
    const size_t corners = (size_t)pbwt__corners(t);
    pbwt__doubts *doubts = c->doubts + from / PBWT__RANGE;
    size_t tested = to - from, k, j;
    for (; from < to; from++) {
        const size_t first = c->wave[from] * corners;
        int room = pbwt__inquire(t, c->wave[from], 0, doubts);
        for (k = 0; k < corners && room; k++) {
            int asked = 0;
            if (t->level.mesh.neighbors[first + k] != PBW_NONE) {
                continue;
            }
            for (j = 0; j < corners; j++) {
                asked |= j != k && pbwt__state(t, pbwt__local(t, t->level.mesh.simplices[first + j])) == PBWT__ASKED;
            }
            if (asked) {
                room = pbwt__inquire(t, c->wave[from], (int)k + 1, doubts);
                tested++;
            }
        }
        if (!room) {
            return PBW_ERROR_MEMORY;
        }
    }
    (void)PBW_ATOMIC_ADD(&c->tested, tested);
    return PBW_OK;
}

static int pbwt__has_asked(const struct pbwt__tile *t, size_t simplex)
{
    const size_t corners = (size_t)pbwt__corners(t);
    size_t k;
    int asked = 0;
    for (k = 0; k < corners; k++) {
        asked |= pbwt__state(t, pbwt__local(t, t->level.mesh.simplices[simplex * corners + k])) == PBWT__ASKED;
    }
    return asked;
}

/* Returns whether certification starts at this simplex; in later levels, at all with a corner to be certified. */
static int pbwt__starts(const struct pbwt__tile *t, size_t simplex)
{
    const size_t corners = (size_t)pbwt__corners(t);
    size_t k;
    int border = t->level.map.at != NULL;
    for (k = 0; k < corners && !border; k++) {
        border = t->level.mesh.simplices[simplex * corners + k] >= t->own
              || t->level.mesh.neighbors[simplex * corners + k] == PBW_NONE;
    }
    return border && pbwt__has_asked(t, simplex);
}

/* Gives up all vertices that were to be certified, instead of asking. */
static void pbwt__give_up(struct pbwt__tile *t)
{
    size_t i;
    for (i = 0; i < t->own; i++) {
        if (t->state.at[i] == PBWT__ASKED) {
            t->state.at[i] = PBWT__GIVEN;
        }
    }
    pbwt__drop_requests(t);
}

static pbw_status pbwt__find_starts(void *arg, size_t from, size_t to)
{
    struct pbwt__tile *t = (struct pbwt__tile *)arg;
    for (; from < to; from++) {
        t->mark.at[from] = (unsigned char)pbwt__starts(t, from);
    }
    return PBW_OK;
}

/* Asks the questions of a range, and queues the neighbours of simplices in doubt. */
static int pbwt__ask_range(struct pbwt__tile *t, const pbwt__doubts *doubts)
{
    const size_t corners = (size_t)pbwt__corners(t);
    const pbwt__doubt *doubt = doubts->at;
    size_t i, k;
    for (i = 0; i < doubts->count; i++) {
        pbwt__question q;
        pbwt__question_of(t, doubt[i].simplex, (int)doubt[i].facet, &q);
        if (!pbwt__request(t, doubt[i].part, &q, sizeof q, doubt[i].simplex)) {
            return 0;
        }
        t->tile->numbers.questions++;
        if (i > 0 && doubt[i].simplex == doubt[i - 1].simplex) {
            t->tile->numbers.uncertified += doubt[i].facet != doubt[i - 1].facet;
            continue;
        }
        t->tile->numbers.uncertified++;
        for (k = 0; k < corners; k++) {
            const pbw_index n = t->level.mesh.neighbors[doubt[i].simplex * corners + k];
            if (n != PBW_NONE && !t->mark.at[n]) {
                t->mark.at[n] = 1;
                if (pbwt__has_asked(t, n) && !PBW_PUSH(&t->memory, t->queue, n)) {
                    return 0;
                }
            }
        }
    }
    return 1;
}

/* Tests count simplices of the queue from `first` on. */
static pbw_status pbwt__test_wave(struct pbwt__tile *t, size_t first, size_t count, const pbw_options *options)
{
    const size_t ranges = (count + PBWT__RANGE - 1) / PBWT__RANGE;
    pbwt__doubts doubts[PBWT__WAVE / PBWT__RANGE];
    pbwt__certifying c;
    pbw_status status;
    size_t i;
    memset(doubts, 0, sizeof doubts);
    c.t = t;
    c.wave = t->queue.at + first;
    c.doubts = doubts;
    c.tested = 0;
    status = pbw_for(options, count, PBWT__RANGE, pbwt__test_range, &c);
    t->tile->numbers.tested += c.tested;
    for (i = 0; i < ranges; i++) {
        if (status == PBW_OK && !pbwt__ask_range(t, doubts + i)) {
            status = PBW_ERROR_MEMORY;
        }
        PBW_RELEASE(&t->memory, doubts[i]);
    }
    return status;
}

/* Estimates, from a sample of the queue, whether its simplices will have more than `most` questions. */
static pbw_status pbwt__guess(struct pbwt__tile *t, size_t most, const pbw_options *options, int *too_many)
{
    const size_t step = 1 + t->queue.count / PBWT__RANGE;
    uint32_t some[PBWT__RANGE];
    pbwt__doubts doubts = { NULL, 0, 0 };
    pbwt__certifying c;
    pbw_status status;
    size_t i, n = 0;
    for (i = 0; i < t->queue.count; i += step) {
        some[n++] = t->queue.at[i];
    }
    c.t = t;
    c.wave = some;
    c.doubts = &doubts;
    c.tested = 0;
    status = pbw_for(options, n, PBWT__RANGE, pbwt__test_range, &c);
    *too_many = status == PBW_OK && (double)doubts.count * (double)step > 2 * (double)most;
    PBW_RELEASE(&t->memory, doubts);
    return status;
}

/* Returns whether the queue asks too many questions: the simplices tested so far have more than `most`, or the
   forecast for all is above 1.25 `most`.  The forecast gives each waiting simplex the mean of the tested ones, which
   may be too much. */
static int pbwt__is_over(const struct pbwt__tile *t, size_t questions, size_t tested, size_t most)
{
    const double each = (double)questions / (double)tested;
    return questions > most
        || (tested >= PBWT__WAVE && each * (double)t->queue.count > 1.25 * (double)most);
}

static pbw_status pbwt__certify(struct pbwt__tile *t)
{
    const size_t simplices = t->level.mesh.simplex_count, before = t->tile->numbers.questions;
    const size_t most = t->options.questions > 0 ? (size_t)(t->options.questions * (double)t->own)
                      : 8 * t->own + 10000;
    const pbw_options options = pbwt__inner_options(t);
    int too_many = 0;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i, count;
    t->queue.count = 0;
    if (PBW_ZEROS(&t->memory, t->mark, simplices)) {
        status = pbw_for(&options, simplices, PBWT__SCAN, pbwt__find_starts, t);
    }
    for (i = 0; i < simplices && status == PBW_OK; i++) {
        const uint32_t start = (uint32_t)i;
        if (t->mark.at[i] && !PBW_PUSH(&t->memory, t->queue, start)) {
            status = PBW_ERROR_MEMORY;
        }
    }
    if (status == PBW_OK && t->queue.count > 16 * PBWT__RANGE) {
        status = pbwt__guess(t, most, &options, &too_many);
    }
    for (i = 0; i < t->queue.count && status == PBW_OK && !too_many; i += count) {
        count = t->queue.count - i < PBWT__WAVE ? t->queue.count - i : (size_t)PBWT__WAVE;
        status = pbwt__test_wave(t, i, count, &options);
        too_many = pbwt__is_over(t, t->tile->numbers.questions - before, i + count, most);
    }
    if (too_many && status == PBW_OK) {
        pbwt__give_up(t);
    }
    PBW_RELEASE(&t->memory, t->mark);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>emission     Which simplices are given out, and their links.
   In: a mesh, a byte for each simplex.  Out: calls of options.emit; facets to be matched across parts.
   Holds: the part of the corner with the smallest id emits a simplex, and no other does.  Leftovers use it too.
   ------------------------------------------------------------------------------------------------------ */

typedef struct pbwt__emission {
    pbwt_tile *tile;
    const pbwt_options *options;
    pbw_memory *memory;
    const pbw_mesh *mesh;
    uint32_t part;
    size_t base;                                     /* number of the first simplex */
    pbwt__bytes chosen;                              /* per simplex: 1 = emitted */
    pbwt__numbers first;                             /* per PBWT__RUN simplices: the number of the first emitted one
                                                        there or after */
    pbwt__facets facets;                             /* out */
} pbwt__emission;

enum { PBWT__BLOCK = 2048, PBWT__RUN = 64 };

/* Counts the chosen simplices of each run.  Returns 0 without memory. */
static int pbwt__count_runs(pbwt__emission *e)
{
    const unsigned char *chosen = e->chosen.at;
    const size_t runs = (e->mesh->simplex_count + PBWT__RUN - 1) / PBWT__RUN;
    size_t s = 0, run, n = e->base;
    if (!PBW_FIT(e->memory, e->first, runs + 1)) {
        return 0;
    }
    for (run = 0; run < runs; run++) {
        e->first.at[run] = (uint32_t)n;
        for (; s < (run + 1) * PBWT__RUN && s < e->mesh->simplex_count; s++) {
            n += chosen[s];
        }
    }
    e->first.at[runs] = (uint32_t)n;
    return 1;
}

/* Of bytes 0 and 1, fewer than PBWT__RUN. */
static uint32_t pbwt__count_ones(const unsigned char *bytes, size_t count)
{
    uint64_t sum = 0, eight;
    for (; count >= 8; count -= 8, bytes += 8) {
        memcpy(&eight, bytes, 8);
        sum += eight;
    }
    for (; count > 0; count--) {
        sum += bytes[count - 1];
    }
    return (uint32_t)(sum * 0x0101010101010101u >> 56);
}

/* The number of a simplex, PBW_NONE if it is not emitted.  In most runs all or none are. */
static uint32_t pbwt__number_of(const pbwt__emission *e, size_t s)
{
    const unsigned char *chosen = e->chosen.at;
    const uint32_t *first = e->first.at + s / PBWT__RUN;
    if (first[1] - first[0] == PBWT__RUN) {
        return first[0] + (uint32_t)(s % PBWT__RUN);
    }
    return chosen[s] ? first[0] + pbwt__count_ones(chosen + s / PBWT__RUN * PBWT__RUN, s % PBWT__RUN) : PBW_NONE;
}

static int pbwt__id_before(const void *a, const void *b, int how)
{
    uint64_t x, y;
    (void)how;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return x < y;
}

typedef struct pbwt__corner { uint64_t id; uint32_t local; } pbwt__corner;

static uint32_t pbwt__owner(const pbwt_tile *tile, uint32_t local)               /* the part of a point of a tile */
{
    const size_t own = tile->tree != NULL ? tile->tree->count : 0;
    return local < own ? (uint32_t)tile->tree->part : tile->foreign[local - own].part;
}

/* Notes the facet opposite to `corner`, which another part may have too. */
static int pbwt__open_facet(pbwt__emission *e, const pbwt__corner *corners, size_t number, size_t corner)
{
    const size_t count = (size_t)e->mesh->dim + 1;
    const pbwt__corner *least = NULL;
    pbwt_facet facet;
    size_t k, n = 0;
    memset(&facet, 0, sizeof facet);
    for (k = 0; k < count; k++) {
        if (k != corner) {
            facet.id[n++] = corners[k].id;
            least = least == NULL || corners[k].id < least->id ? corners + k : least;
        }
    }
    pbwt__sort(facet.id, n, sizeof *facet.id, pbwt__id_before, 0);
    facet.from = (uint64_t)e->part << 40 | (uint64_t)number << 2 | corner;
    facet.to = pbwt__owner(e->tile, least->local);
    return PBW_PUSH(e->memory, e->facets, facet);
}

/* The links of one simplex to others that are emitted.  Returns whether these are all. */
static int pbwt__links_inside(const pbwt__emission *e, size_t simplex, uint32_t *links)
{
    const size_t corners = (size_t)e->mesh->dim + 1;
    int all = 1;
    size_t k;
    for (k = 0; k < corners; k++) {
        const pbw_index n = e->mesh->neighbors[simplex * corners + k];
        links[k] = n != PBW_NONE ? pbwt__number_of(e, n) : PBW_NONE;
        all &= links[k] != PBW_NONE;
    }
    return all;
}

/* The other links.  The star of the corner with the smallest id is final: facets at it without a neighbour are of
   the hull. */
static int pbwt__links_outside(pbwt__emission *e, size_t simplex, const pbwt__corner *corner, uint32_t *links)
{
    const size_t corners = (size_t)e->mesh->dim + 1;
    size_t k, first = 0;
    for (k = 1; k < corners; k++) {
        first = corner[k].id < corner[first].id ? k : first;
    }
    for (k = 0; k < corners; k++) {
        if (links[k] == PBW_NONE && e->mesh->neighbors[simplex * corners + k] == PBW_NONE && k != first) {
            links[k] = PBWT_HULL;
            e->tile->numbers.hull++;
        } else if (links[k] == PBW_NONE) {
            links[k] = PBWT_OPEN;
            if (!pbwt__open_facet(e, corner, pbwt__number_of(e, simplex), k)) {
                return 0;
            }
        }
    }
    return 1;
}

/* Names a point of the mesh: its number in the tile, and its id unless that is NULL. */
typedef void pbwt__naming(const void *user, pbw_index vertex, uint32_t *local, uint64_t *id);

/* Fills corners and links of one simplex.  Returns 0 without memory. */
static int pbwt__emit_one(pbwt__emission *e, size_t s, pbwt__naming *name, const void *user, uint32_t *corner,
                          uint32_t *links)
{
    const size_t corners = (size_t)e->mesh->dim + 1;
    const int inside = e->options->no_links || pbwt__links_inside(e, s, links);
    pbwt__corner named[4];
    size_t k;
    for (k = 0; k < corners; k++) {
        name(user, e->mesh->simplices[s * corners + k], &named[k].local, inside ? NULL : &named[k].id);
        corner[k] = named[k].local;
    }
    return inside || pbwt__links_outside(e, s, named, links);
}

static pbw_status pbwt__hand_over(const pbwt__emission *e, size_t first, size_t count, const uint32_t *corners,
                                  const uint32_t *links)
{
    return e->options->emit == NULL ? PBW_OK
         : e->options->emit(e->options->emit_user, e->tile, first, count, corners, links);
}

static pbw_status pbwt__emit(pbwt__emission *e, pbwt__naming *name, const void *user)
{
    const size_t corners = (size_t)e->mesh->dim + 1;
    uint32_t corner[PBWT__BLOCK * 4], links[PBWT__BLOCK * 4];
    size_t s, count = 0, first = e->base;
    pbw_status status = PBW_OK;
    if (e->options->no_links && e->options->emit == NULL) {
        return PBW_OK;
    }
    if (!pbwt__count_runs(e)) {
        return PBW_ERROR_MEMORY;
    }
    memset(links, 0xff, sizeof links);
    for (s = 0; s < e->mesh->simplex_count && status == PBW_OK; s++) {
        if (!e->chosen.at[s]) {
            continue;
        }
        if (!pbwt__emit_one(e, s, name, user, corner + count * corners, links + count * corners)) {
            return PBW_ERROR_MEMORY;
        }
        if (++count == PBWT__BLOCK) {
            status = pbwt__hand_over(e, first, count, corner, links);
            first += count;
            count = 0;
        }
    }
    return status == PBW_OK && count > 0 ? pbwt__hand_over(e, first, count, corner, links) : status;
}

/* ---- emission of a level */

static void pbwt__name_local(const void *user, pbw_index vertex, uint32_t *local, uint64_t *id)
{
    const struct pbwt__tile *t = (const struct pbwt__tile *)user;
    *local = pbwt__local(t, vertex);
    if (id != NULL) {
        *id = pbwt__point(t, *local)->id;
    }
}

static int pbwt__is_final(int state)
{
    return state == PBWT__SUBJECT || state == PBWT__ASKED;
}

/* To be emitted; with final corners and ones perhaps given up; at a star in repair. */
enum { PBWT__CHOSEN = 1, PBWT__BORDER = 2, PBWT__REPAIR = 4 };

typedef struct pbwt__choosing { const struct pbwt__tile *t; unsigned char *chosen; } pbwt__choosing;

/* Returns whether a simplex of the first level has only own corners, and no answer changed their stars.  Most are so.
   */
static int pbwt__is_inside(const struct pbwt__tile *t, const pbw_index *corner)
{
    const size_t corners = (size_t)pbwt__corners(t);
    size_t k;
    int inside = t->level.map.at == NULL;
    for (k = 0; k < corners && inside; k++) {
        inside = corner[k] < t->own && t->state.at[corner[k]] == PBWT__ASKED;
    }
    return inside;
}

static unsigned char pbwt__choose(const struct pbwt__tile *t, size_t s)
{
    const size_t corners = (size_t)pbwt__corners(t);
    uint32_t local[4];
    uint64_t least = 0;
    int final = 0, others = 0, doubtful = 0, repair = 0, chosen = 1;
    size_t k;
    if (pbwt__is_inside(t, t->level.mesh.simplices + s * corners)) {
        return PBWT__CHOSEN;
    }
    for (k = 0; k < corners; k++) {
        int state;
        local[k] = pbwt__local(t, t->level.mesh.simplices[s * corners + k]);
        state = pbwt__state(t, local[k]);
        final |= pbwt__is_final(state);
        others |= !pbwt__is_final(state);
        doubtful |= local[k] >= t->own || state >= PBWT__AFFECTED;
        repair |= state == PBWT__AFFECTED || state == PBWT__MORE;
    }
    for (k = 0; k < corners && others; k++) {        /* without others, whichever id is the smallest */
        const uint64_t id = pbwt__point(t, local[k])->id;
        if (k == 0 || id < least) {
            least = id;
            chosen = pbwt__is_final(pbwt__state(t, local[k]));
        }
    }
    return (unsigned char)((chosen ? PBWT__CHOSEN : 0) | (final && doubtful ? PBWT__BORDER : 0)
                           | (repair ? PBWT__REPAIR : 0));
}

static pbw_status pbwt__choose_range(void *arg, size_t from, size_t to)
{
    const pbwt__choosing *c = (const pbwt__choosing *)arg;
    for (; from < to; from++) {
        c->chosen[from] = pbwt__choose(c->t, from);
    }
    return PBW_OK;
}

static int pbwt__keep_border(struct pbwt__tile *t, size_t s)
{
    const size_t corners = (size_t)pbwt__corners(t);
    size_t k;
    int room = 1;
    for (k = 0; k < corners && room; k++) {
        room = PBW_PUSH(&t->memory, t->border, pbwt__local(t, t->level.mesh.simplices[s * corners + k]));
    }
    return room;
}

static pbw_status pbwt__hash_level(struct pbwt__tile *t, pbwt__emission *e)
{
    pbw_options options = pbwt__inner_options(t);
    pbw_hash_sums sums;
    pbwt__bytes points = { NULL, 0, 0 };
    pbw_status status;
    if (!PBW_ZEROS(&t->memory, points, t->level.mesh.point_count)) {
        return PBW_ERROR_MEMORY;
    }
    if (t->level.map.at == NULL) {
        memset(points.at, 1, t->own);
    }
    status = pbw_hash_parts(&t->level.mesh, points.at, e->chosen.at, &options, &sums);
    PBW_RELEASE(&t->memory, points);
    t->tile->hash.points += status == PBW_OK ? sums.points : 0;
    t->tile->hash.simplices += status == PBW_OK ? sums.simplices : 0;
    return status;
}

/* Notes a simplex of the border or at a star in repair. */
static int pbwt__note(struct pbwt__tile *t, size_t s, int choice)
{
    const uint32_t simplex = (uint32_t)s;
    return ((choice & PBWT__BORDER) == 0 || pbwt__keep_border(t, s))
        && ((choice & PBWT__REPAIR) == 0 || PBW_PUSH(&t->memory, t->queue, simplex));
}

/* Counts the chosen simplices, and takes notes of the others.  Returns 0 without memory. */
static int pbwt__count_chosen(struct pbwt__tile *t, pbwt__emission *e, size_t *count)
{
    unsigned char *chosen = e->chosen.at;
    size_t s, n = e->base;
    t->queue.count = 0;
    for (s = 0; s < e->mesh->simplex_count; s++) {
        const int choice = chosen[s];
        if (choice > PBWT__CHOSEN && !pbwt__note(t, s, choice)) {
            return 0;
        }
        chosen[s] = choice & PBWT__CHOSEN;
        n += choice & PBWT__CHOSEN;
    }
    *count = n;
    return 1;
}

static pbw_status pbwt__emit_chosen(struct pbwt__tile *t, pbwt__emission *e)
{
    const size_t count = t->level.mesh.simplex_count;
    const pbw_options options = pbwt__inner_options(t);
    pbwt__choosing choosing;
    size_t n;
    pbw_status status;
    if (!PBW_ZEROS(&t->memory, e->chosen, count)) {
        return PBW_ERROR_MEMORY;
    }
    choosing.t = t;
    choosing.chosen = e->chosen.at;
    status = pbw_for(&options, count, PBWT__SCAN, pbwt__choose_range, &choosing);
    if (status != PBW_OK) {
        return status;
    }
    if (!pbwt__count_chosen(t, e, &n)) {
        return PBW_ERROR_MEMORY;
    }
    if (n > 0xfffffff0u) {
        return PBW_ERROR_TOO_LARGE;
    }
    status = pbwt__hash_level(t, e);                 /* before facets take memory */
    e->facets = t->facets;
    status = status == PBW_OK ? pbwt__emit(e, pbwt__name_local, t) : status;
    t->facets = e->facets;
    t->tile->facets = t->facets.at;
    t->tile->facet_count = t->facets.count;
    t->tile->numbers.simplices = n;
    return status;
}

static pbw_status pbwt__emit_level(struct pbwt__tile *t)
{
    pbwt__emission e;
    pbw_status status;
    size_t i;
    memset(&e, 0, sizeof e);
    e.tile = t->tile;
    e.options = &t->options;
    e.memory = &t->memory;
    e.mesh = &t->level.mesh;
    e.part = (uint32_t)t->tile->tree->part;
    e.base = t->tile->numbers.simplices;
    status = pbwt__emit_chosen(t, &e);
    PBW_RELEASE(&t->memory, e.first);
    PBW_RELEASE(&t->memory, e.chosen);
    for (i = 0; i < t->own && status == PBW_OK; i++) {
        if (pbwt__is_final(t->state.at[i])) {
            t->state.at[i] = PBWT__DONE;
        }
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>repair       The next level; the stages in order.
   In: a level after its replies.  Out: the next one, or the end.
   Holds: each own vertex is final in one level, or given up.
   ------------------------------------------------------------------------------------------------------ */

/* Replaces the level by the triangulation of the neighbours of stars in repair, whose simplices are in the queue, and
   the new points. */
static pbw_status pbwt__repair(struct pbwt__tile *t)
{
    const size_t corners = (size_t)pbwt__corners(t);
    pbwt__level next;
    pbw_status status;
    size_t s, k, i, stars = 0;
    int room = PBW_ZEROS(&t->memory, t->mark, t->level.mesh.point_count);
    memset(&next, 0, sizeof next);
    for (s = 0; s < t->queue.count && room; s++) {
        const pbw_index *corner = t->level.mesh.simplices + t->queue.at[s] * corners;
        for (k = 0; k < corners && room; k++) {
            const uint32_t local = pbwt__local(t, corner[k]);
            if (!t->mark.at[corner[k]]) {
                t->mark.at[corner[k]] = 1;
                room = PBW_PUSH(&t->memory, next.map, local);
            }
        }
    }
    for (i = t->own + t->before; i < t->own + t->foreign.count && room; i++) {
        const uint32_t local = (uint32_t)i;
        room = PBW_PUSH(&t->memory, next.map, local);
    }
    PBW_RELEASE(&t->memory, t->mark);
    pbwt__level_free(t, &t->level);
    t->level = next;
    if (!room) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < t->own; i++) {
        unsigned char *state = t->state.at + i;
        if (*state == PBWT__AFFECTED || *state == PBWT__MORE) {
            *state = *state == PBWT__MORE ? PBWT__ASKED : PBWT__SUBJECT;
            stars++;
        }
    }
    t->tile->numbers.patched += stars;
    if (stars == 0) {
        pbwt__level_free(t, &t->level);
        return PBW_OK;
    }
    t->tile->numbers.patch_points += next.map.count;
    status = pbwt__triangulate(t, next.map.count);
    return status;
}

/* Subjects of a level without simplices are given up: local points are all in a plane, or on a line. */
static void pbwt__give_up_flat(struct pbwt__tile *t)
{
    size_t i;
    for (i = 0; i < t->own && t->level.mesh.simplex_count == 0; i++) {
        unsigned char *state = t->state.at + i;
        if (pbwt__is_final(*state)) {
            *state = PBWT__GIVEN;
        }
    }
}

static pbw_status pbwt__list_given(struct pbwt__tile *t)
{
    uint32_t i;
    for (i = 0; i < t->own; i++) {
        if (t->state.at[i] == PBWT__GIVEN && !PBW_PUSH(&t->memory, t->given, i)) {
            return PBW_ERROR_MEMORY;
        }
    }
    t->tile->border = t->border.at;
    t->tile->border_count = t->border.count;
    t->tile->leftovers = t->given.at;
    t->tile->leftover_count = t->tile->numbers.given_up = t->given.count;
    return PBW_OK;
}

/* ---- the stages */

/* The points are there: triangulates, or repairs, and asks. */
static pbw_status pbwt__next_level(struct pbwt__tile *t, int *more)
{
    pbw_status status;
    pbwt__drop_requests(t);                          /* they were answered */
    if (t->stage == 1) {
        t->tile->numbers.halo = t->foreign.count;
        status = t->tile->tree->memory != NULL ? pbwt__triangulate_in_place(t)
               : pbwt__triangulate(t, t->own + t->foreign.count);
        pbwt__give_up_flat(t);
    } else {
        t->tile->numbers.later += t->foreign.count - t->before;
        status = pbwt__emit_level(t);
        status = status != PBW_OK ? status : pbwt__repair(t);
        if (status == PBW_OK && t->level.map.at != NULL) {
            pbwt__give_up_flat(t);
        }
    }
    if (status == PBW_OK) {
        t->before = t->foreign.count;
        status = pbwt__certify(t);
    }
    *more = status == PBW_OK && pbwt__end_requests(t, PBWT__ASK);
    t->tile->numbers.rounds += *more != 0;
    return status;
}

PBWDEF pbw_status pbwt_ask(pbwt_tile *tile, int *more)
{
    struct pbwt__tile *t = tile->memory;
    pbw_status status = PBW_OK;
    *more = 0;
    if (t == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    tile->foreign = t->foreign.at;
    tile->foreign_count = t->foreign.count;
    if (t->stage == 0 && t->own > 0) {
        status = pbwt__want_halo(t);
        t->stage = 1;
        if (status == PBW_OK && pbwt__end_requests(t, PBWT__WANT)) {
            *more = 1;
            return PBW_OK;
        }
    }
    while (status == PBW_OK && t->own > 0 && t->stage > 0 && !*more) {
        status = pbwt__next_level(t, more);
        t->stage++;
        if (status == PBW_OK && !*more && t->level.map.at == NULL && t->level.mesh.point_count == 0) {
            t->stage = -1;                           /* nothing left to emit or repair */
            status = pbwt__list_given(t);
        }
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>leftovers    Vertices given up, by one part.
   In: what all tiles know of them.  Out: their simplices.
   Let U be the vertices given up and C the others, with exact stars.  The star of u in U among all points is its star
   among U and the neighbours in C of U, since these neighbours know u, and the star is closed.  With weights a vertex
   of U may be hidden, but appear among so few points; then its simplices have only hidden vertices in common.  So
   simplices count only if corners in U connect them to a vertex that a vertex of C knows as a neighbour.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwt__known { uint64_t given, nearby, seen, emitted; } pbwt__known;       /* vertices, vertices, ids */

static int pbwt__is_in(const uint64_t *ids, size_t count, uint64_t id)
{
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (ids[middle] < id) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < count && ids[low] == id;
}

typedef struct pbwt__knowing {
    const pbwt_tile *tile;
    pbw_memory memory;
    pbwt__vertices vertices;
    PBW_ARRAY(uint64_t) seen;                        /* ids */
    pbwt__bytes done;                                /* per own point: it is in vertices */
} pbwt__knowing;

static int pbwt__add_known(pbwt__knowing *k, uint32_t own)
{
    pbwt_vertex vertex;
    if (k->done.at[own]) {
        return 1;
    }
    k->done.at[own] = 1;
    vertex.point = k->tile->tree->points[own];
    vertex.part = (uint32_t)k->tile->tree->part;
    vertex.index = own;
    return PBW_PUSH(&k->memory, k->vertices, vertex);
}

/* Adds the corners of one simplex of the border if any was given up. */
static int pbwt__know_simplex(pbwt__knowing *k, const uint32_t *corner, const uint64_t *ids, size_t count)
{
    const pbwt_tile *tile = k->tile;
    const size_t corners = (size_t)tile->dim + 1, own = tile->tree->count;
    size_t i;
    int nearby = 0, room = 1;
    for (i = 0; i < corners && room; i++) {
        const uint64_t id = corner[i] < own ? tile->tree->points[corner[i]].id
                          : tile->foreign[corner[i] - own].point.id;
        if (pbwt__is_in(ids, count, id)) {
            nearby = 1;
            room = PBW_PUSH(&k->memory, k->seen, id);
        }
    }
    for (i = 0; i < corners && nearby && room; i++) {
        room = corner[i] >= own || pbwt__add_known(k, corner[i]);
    }
    return room;
}

/* Adds own points given up, then own points beside any that are; the ids of those are `seen`. */
static int pbwt__find_known(pbwt__knowing *k, const uint64_t *ids, size_t count)
{
    const pbwt_tile *tile = k->tile;
    const size_t corners = (size_t)tile->dim + 1;
    size_t i;
    int room = PBW_ZEROS(&k->memory, k->done, tile->tree->count);
    for (i = 0; i < tile->leftover_count && room; i++) {
        room = pbwt__add_known(k, tile->leftovers[i]);
    }
    for (i = 0; i + corners <= tile->border_count && room; i += corners) {
        room = pbwt__know_simplex(k, tile->border + i, ids, count);
    }
    return room;
}

PBWDEF pbw_status pbwt_leftovers(const pbwt_tile *tile, const uint64_t *ids, size_t count, pbwt_bytes *out)
{
    pbwt__knowing k;
    pbwt__known head;
    size_t vertices, size;
    char *text;
    memset(&k, 0, sizeof k);
    memset(out, 0, sizeof *out);
    if (tile->tree == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    k.tile = tile;
    k.memory = pbwt__memory_beside(tile->tree);
    if (pbwt__find_known(&k, ids, count)) {
        head.given = tile->leftover_count;
        head.nearby = k.vertices.count - tile->leftover_count;
        head.seen = k.seen.count;
        head.emitted = tile->numbers.simplices;
        vertices = k.vertices.count * sizeof(pbwt_vertex);
        size = sizeof head + vertices + k.seen.count * 8;
        text = (char *)pbw_memory_resize(&k.memory, NULL, 0, size, 1);
        if (text != NULL) {
            memcpy(text, &head, sizeof head);
            memcpy(text + sizeof head, vertices > 0 ? (const void *)k.vertices.at : &head, vertices);
            memcpy(text + sizeof head + vertices, k.seen.count > 0 ? (const void *)k.seen.at : &head,
                   k.seen.count * 8);
            out->data = text;
            out->size = size;
        }
    }
    PBW_RELEASE(&k.memory, k.vertices);
    PBW_RELEASE(&k.memory, k.seen);
    PBW_RELEASE(&k.memory, k.done);
    return out->data != NULL ? PBW_OK : PBW_ERROR_MEMORY;
}

typedef struct pbwt__rest {                          /* of pbwt_finish */
    struct pbwt__tile *t;
    size_t given;                                    /* the first vertices of tile.foreign */
    pbwt__numbers group;                             /* per vertex given up: towards the least of its component */
    pbwt__bytes wanted;                              /* per vertex given up: its component counts */
    PBW_ARRAY(uint64_t) seen;                        /* ids, ascending */
    int others;                                      /* are there vertices that were not given up? */
} pbwt__rest;

/* Reads the vertices (which = 0: given up, 1: near) or the ids (2) of what tiles know. */
static pbw_status pbwt__read_known(pbwt__rest *rest, const pbwt_bytes *known, int which)
{
    struct pbwt__tile *t = rest->t;
    size_t at = 0;
    while (at < known->size) {
        const size_t left = known->size - at - sizeof(pbwt__known);
        pbwt__known head;
        const char *from;
        size_t skip, count;
        if (known->size - at < sizeof head) {
            return PBW_ERROR_ARGUMENT;
        }
        memcpy(&head, known->data + at, sizeof head);
        if (head.given > left / sizeof(pbwt_vertex) || head.nearby > left / sizeof(pbwt_vertex)
            || head.seen > left / 8 || (head.given + head.nearby) * sizeof(pbwt_vertex) + head.seen * 8 > left) {
            return PBW_ERROR_ARGUMENT;
        }
        skip = (size_t)(which == 0 ? 0 : which == 1 ? head.given : head.given + head.nearby) * sizeof(pbwt_vertex);
        count = (size_t)(which == 0 ? head.given : which == 1 ? head.nearby : head.seen);
        from = known->data + at + sizeof head + skip;
        if (which < 2 ? !PBW_RESERVE(&t->memory, t->foreign, count) : !PBW_RESERVE(&t->memory, rest->seen, count)) {
            return PBW_ERROR_MEMORY;
        }
        if (which < 2 && count > 0) {
            memcpy(t->foreign.at + t->foreign.count, from, count * sizeof *t->foreign.at);
            t->foreign.count += count;
        } else if (count > 0) {
            memcpy(rest->seen.at + rest->seen.count, from, count * sizeof *rest->seen.at);
            rest->seen.count += count;
        }
        rest->others |= head.nearby > 0 || head.emitted > 0;
        at += sizeof head + (size_t)(head.given + head.nearby) * sizeof(pbwt_vertex) + (size_t)head.seen * 8;
    }
    return PBW_OK;
}

static uint32_t pbwt__least(const pbwt__rest *rest, uint32_t v)
{
    uint32_t *group = rest->group.at;
    while (group[v] != v) {
        group[v] = group[group[v]];
        v = group[v];
    }
    return v;
}

/* Which components of vertices given up count. */
static pbw_status pbwt__components(pbwt__rest *rest)
{
    struct pbwt__tile *t = rest->t;
    const size_t corners = (size_t)pbwt__corners(t);
    const pbwt_vertex *vertex = t->foreign.at;
    size_t i, k;
    if (!PBW_FIT(&t->memory, rest->group, rest->given + 1)
        || !PBW_ZEROS(&t->memory, rest->wanted, rest->given)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < rest->given; i++) {
        rest->group.at[i] = (uint32_t)i;
    }
    for (i = 0; i < t->level.mesh.simplex_count; i++) {
        const pbw_index *corner = t->level.mesh.simplices + i * corners;
        uint32_t last = PBW_NONE;
        for (k = 0; k < corners; k++) {
            if (corner[k] < rest->given) {
                const uint32_t root = pbwt__least(rest, corner[k]);
                if (last != PBW_NONE) {
                    rest->group.at[root > last ? root : last] = root > last ? last : root;
                }
                last = last == PBW_NONE || root < last ? root : last;
            }
        }
    }
    pbwt__sort(rest->seen.at, rest->seen.count, sizeof(uint64_t), pbwt__id_before, 0);
    for (i = 0; i < rest->given; i++) {
        if (!rest->others || pbwt__is_in(rest->seen.at, rest->seen.count, vertex[i].point.id)) {
            rest->wanted.at[pbwt__least(rest, (uint32_t)i)] = 1;
        }
    }
    return PBW_OK;
}

static pbw_status pbwt__emit_rest(pbwt__rest *rest, pbwt__emission *e)
{
    struct pbwt__tile *t = rest->t;
    const size_t corners = (size_t)pbwt__corners(t);
    const pbwt_vertex *vertex = t->foreign.at;
    size_t s, k, n = 0;
    pbw_status status;
    if (!PBW_ZEROS(&t->memory, e->chosen, e->mesh->simplex_count)) {
        return PBW_ERROR_MEMORY;
    }
    for (s = 0; s < e->mesh->simplex_count; s++) {
        const pbw_index *corner = e->mesh->simplices + s * corners;
        pbw_index least = corner[0];
        int chosen;
        for (k = 1; k < corners; k++) {
            least = vertex[corner[k]].point.id < vertex[least].point.id ? corner[k] : least;
        }
        chosen = least < rest->given && rest->wanted.at[pbwt__least(rest, least)];
        e->chosen.at[s] = (unsigned char)chosen;
        n += chosen != 0;
    }
    status = pbwt__emit(e, pbwt__name_local, t);
    t->facets = e->facets;
    t->tile->facets = t->facets.at;
    t->tile->facet_count = t->facets.count;
    t->tile->numbers.simplices = n;
    return status == PBW_OK ? pbwt__hash_level(t, e) : status;
}

static pbw_status pbwt__finish_rest(pbwt__rest *rest, int parts, const pbwt_bytes *known)
{
    struct pbwt__tile *t = rest->t;
    pbwt__emission e;
    pbw_status status = pbwt__read_known(rest, known, 0);
    memset(&e, 0, sizeof e);
    rest->given = t->foreign.count;
    status = status != PBW_OK ? status : pbwt__read_known(rest, known, 1);
    status = status != PBW_OK ? status : pbwt__read_known(rest, known, 2);
    status = status != PBW_OK ? status : pbwt__triangulate(t, t->foreign.count);
    status = status != PBW_OK ? status : pbwt__components(rest);
    t->tile->foreign = t->foreign.at;
    t->tile->foreign_count = t->foreign.count;
    t->tile->numbers.given_up = rest->given;
    if (status == PBW_OK) {
        e.tile = t->tile;
        e.options = &t->options;
        e.memory = &t->memory;
        e.mesh = &t->level.mesh;
        e.part = (uint32_t)parts;
        status = pbwt__emit_rest(rest, &e);
        PBW_RELEASE(&t->memory, e.first);
        PBW_RELEASE(&t->memory, e.chosen);
        if (status == PBW_OK && e.mesh->simplex_count == 0 && !rest->others) {
            status = PBW_DEGENERATE;
        }
    }
    pbwt__level_free(t, &t->level);
    return status;
}

PBWDEF pbw_status pbwt_finish(pbwt_tile *tile, int dim, int parts, const pbwt_bytes *known,
                              const pbwt_options *options)
{
    pbwt__rest rest;
    pbwt_options defaults;
    pbw_status status;
    memset(&rest, 0, sizeof rest);
    memset(&defaults, 0, sizeof defaults);
    memset(tile, 0, sizeof *tile);
    tile->dim = dim;
    if (dim < 2 || dim > 3 || parts < 1) {
        return PBW_ERROR_ARGUMENT;
    }
    if (!pbwt__allocate_tile(tile, options != NULL ? options : &defaults)) {
        return PBW_ERROR_MEMORY;
    }
    rest.t = tile->memory;
    status = pbwt__finish_rest(&rest, parts, known);
    PBW_RELEASE(&rest.t->memory, rest.group);
    PBW_RELEASE(&rest.t->memory, rest.wanted);
    PBW_RELEASE(&rest.t->memory, rest.seen);
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        pbwt_close(tile);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>links        Facets across parts.
   In: facets of all parts, each twice but for those of the hull.  Out: for each the simplex on its other side.
   ------------------------------------------------------------------------------------------------------ */
static int pbwt__facet_before(const void *a, const void *b, int how)
{
    const pbwt_facet *x = (const pbwt_facet *)a, *y = (const pbwt_facet *)b;
    int k;
    (void)how;
    for (k = 0; k < 3; k++) {
        if (x->id[k] != y->id[k]) {
            return x->id[k] < y->id[k];
        }
    }
    return x->from < y->from;
}

static int pbwt__from_before(const void *a, const void *b, int how)
{
    (void)how;
    return ((const pbwt_facet *)a)->from < ((const pbwt_facet *)b)->from;
}

PBWDEF size_t pbwt_match(pbwt_facet *facets, size_t count)
{
    size_t i, single = 0;
    pbwt__sort(facets, count, sizeof *facets, pbwt__facet_before, 0);
    for (i = 0; i < count; i++) {
        facets[i].to = PBWT_NOTHING;
        if (i + 1 < count && memcmp(facets[i].id, facets[i + 1].id, sizeof facets->id) == 0) {
            facets[i].to = facets[i + 1].from;
            facets[i + 1].to = facets[i].from;
            i++;
        } else {
            single++;
        }
    }
    pbwt__sort(facets, count, sizeof *facets, pbwt__from_before, 0);
    return single;
}

PBW_CONTRACTION_ON
#endif /* PBW_TILES_IMPLEMENTATION */
