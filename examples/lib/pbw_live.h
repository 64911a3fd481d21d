/* pbw_live.h - v0.2.0 - inserts, removes and moves points of a triangulation - MIT-0

   QUICK START
   In the source file that defines PBW_IMPLEMENTATION, define PBW_LIVE_IMPLEMENTATION too; in others just include.

       #define PBW_IMPLEMENTATION
       #define PBW_LIVE_IMPLEMENTATION
       #include "pbw_live.h"
       #include <stdio.h>

       int main(void) {
           double points[] = { 0,0,  4,0,  0,4,  4,4 }, more[] = { 1,2 };
           pbw_index id;
           pbw_live *live;
           static pbw_mesh mesh;
           pbw_status status = pbw_triangulate(2, points, NULL, 4, NULL, &mesh);
           if (status == PBW_OK) status = pbw_live_create(&mesh, NULL, &live);
           if (status != PBW_OK) { printf("%s\n", pbw_status_string(status)); return 1; }
           pbw_free(&mesh);                                        // live has all that it needs
           status = pbw_live_insert(live, more, NULL, 1, &id);
           if (status == PBW_OK) status = pbw_live_commit(live, NULL);
           if (status == PBW_OK) status = pbw_live_view(live, &mesh);
           if (status == PBW_OK) printf("point %u, %u triangles\n", id, (unsigned)mesh.simplex_count);
           pbw_free(&mesh);
           pbw_live_free(live);
           return status != PBW_OK;
       }

   Build:  cc -O2 quickstart.c -lpthread

   FUNCTIONS
     pbw_live_create   points to insert, remove and move
     pbw_live_free     frees them
     pbw_live_insert   queues new points, and gives their ids
     pbw_live_remove   queues removals
     pbw_live_move     queues moves
     pbw_live_commit   carries out what is queued
     pbw_changes_free  frees what a commit reports
     pbw_live_view     the arrays of the present triangulation

   CONTENTS  (search for the marks)
     >>interface  types and functions
     >>core       a triangulation that persists, and a journal of deleted simplices
     >>apex       the vertex behind a facet of a hole
     >>ears       the hole of a vertex in space, cut off ear by ear
     >>removal    removes or inserts one vertex
     >>creation   from points to a core
     >>verify     after vertices moved: tests whether the triangulation holds; flips
     >>live       points to insert, remove and move: the queue
     >>report     what a commit changed
     >>hints      where walks start, and what batches prefetch
     >>tasks      a batch of changes by many threads
     >>places     the vertices by their coordinates
     >>change     a batch of queued changes: the vertices that leave and arrive
     >>batch      these, removed and inserted
     >>moves      points that keep their neighbours, or most
     >>commit     queued changes carried out
     >>view       the arrays of a live triangulation

   PROMISES  (and the test that guards each)
     same        after each commit the arrays that a build of the points gives, whatever
                 happened before and on any number of threads                               tests/test_live.c
     all or nothing   a commit that fails changes nothing: triangulation and queue stay     tests/test_live.c
     the others  of pbw.h: never exits, re-entrant, bounded                                 tests/test_contract.c

   Words are those of pbw.h's GLOSSARY and CONVENTIONS.

   CONFIGURATION MACROS
     PBW_LIVE_IMPLEMENTATION   in the source file that has PBW_IMPLEMENTATION: compile the implementation there
     and those of pbw.h: PBW_STATIC and PBWDEF, PBW_NO_SIMD, PBW_NO_THREADS, PBW_WIDE
*/
#ifndef PBW_LIVE_H
#define PBW_LIVE_H
/* ------------------------------------------------------------------------------------------------------
   >>interface
   ------------------------------------------------------------------------------------------------------ */
#include "pbw.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- a triangulation that lives: points are inserted, removed and moved, in batches.  One thread at a time may use
   a pbw_live; the meshes that it gives are the caller's, as those of pbw_triangulate, and queries work on them.
   Points have numbers that stay theirs: those of the mesh it was made from, then those that pbw_live_insert gives.
   The number of a removed point is given again, to an insertion after the commit that removed it.
   Its threads sleep between calls, until pbw_live_free; several share threads by options of pbw_threads_start. */
typedef struct pbw_live pbw_live;

typedef enum pbw_way {                     /* how a commit was carried out, which may depend on the threads; the
                                              result does not */
    PBW_WAY_NOTHING,                       /* no simplex changed */
    PBW_WAY_FLIPS,                         /* edges were flipped, in the plane */
    PBW_WAY_BATCH,                         /* points were taken out and put in, one by one */
    PBW_WAY_REBUILD                        /* all was triangulated again */
} pbw_way;

typedef struct pbw_changes {               /* start from {0}; pbw_changes_free when done */
    pbw_way way;
    size_t deleted_count, made_count, point_count;
    const pbw_index *deleted, *made;       /* the dim+1 points of each simplex that went, and of each that came: the
                                              lowest first, positively oriented, in ascending order */
    const pbw_index *points;               /* with another star than before, ascending */
    void *memory;                          /* private */
} pbw_changes;

/* Makes one with the points, weights and numbers of a mesh, which may be freed then: of any flags and backend,
   PBW_DEGENERATE too.  For one without points give a mesh that is {0} but for dim.  Triangulates the points that have
   a canonical one again, so it takes as long as a build, and the result is right whatever simplices and neighbors say
   (borrowed points may have moved).  Returns PBW_DEGENERATE, with a triangulation that may be used, if the points do
   not span the space.  options are for all later calls on it: threads, memory_limit, resize, run, progress; they are
   copied, flags, strides and backend must be 0. */
PBWDEF pbw_status pbw_live_create(const pbw_mesh *mesh, const pbw_options *options, pbw_live **live);
PBWDEF void pbw_live_free(pbw_live *live);         /* fine on NULL */

/* These queue changes for the next commit; on any status but PBW_OK the queue is as before.  Points are packed, dim
   coordinates each.  Numbers must be those of points that are neither removed nor in the queue to be; one that was
   just inserted will do.
   insert: ids (may be NULL) gets the numbers of the new points.  weights NULL: 0 each.  From the first weights on the
   triangulation is a regular one.
   remove: no number twice.
   move: ids NULL: all points; count is the number of all numbers (mesh.point_count), and entries of unused numbers
   are ignored.  If a number occurs twice, its last point is used.  Weights stay. */
PBWDEF pbw_status pbw_live_insert(pbw_live *live, const double *points, const double *weights, size_t count,
                                  pbw_index *ids);
PBWDEF pbw_status pbw_live_remove(pbw_live *live, const pbw_index *ids, size_t count);
PBWDEF pbw_status pbw_live_move(pbw_live *live, const pbw_index *ids, const double *points, size_t count);

/* Carries out all that is queued, and lists in changes (may be NULL, which is quicker) what that changed.  Returns
   PBW_OK, or PBW_DEGENERATE if the points left do not span the space; on any other status the triangulation and the
   queue are as they were.  Takes the way that is likely to be the quickest. */
PBWDEF pbw_status pbw_live_commit(pbw_live *live, pbw_changes *changes);
PBWDEF void pbw_changes_free(pbw_changes *changes);        /* fine on {0}, fine twice */

/* The triangulation after the last commit: returns PBW_OK or PBW_DEGENERATE, and the arrays that pbw_triangulate
   gives for its points in the order of their numbers, with the numbers in place of their ranks.  A number that is
   free has canonical PBW_NONE, incident PBW_NONE and the coordinates 0.  pbw_free the mesh when done. */
PBWDEF pbw_status pbw_live_view(pbw_live *live, pbw_mesh *mesh);

#ifdef __cplusplus
}
#endif
#endif /* PBW_LIVE_H */

/* Interface ends here; what follows is for those who want to know how it works. */

#if defined(PBW_LIVE_IMPLEMENTATION) && !defined(PBWL__IMPLEMENTED)
#define PBWL__IMPLEMENTED
#if PBW__SEAM != 1
#error "pbw_live.h is compiled where pbw.h of its version is: define PBW_IMPLEMENTATION too, above the include"
#else

PBW__SEAM_BEGIN
#ifdef _WIN32
#pragma push_macro("far")
#pragma push_macro("near")
#undef far
#undef near
#endif
/* ------------------------------------------------------------------------------------------------------
   >>core         A triangulation that persists: vertices with numbers, and a journal of deleted simplices.
   In: a triangulation by the kernel.  Out: for each vertex an incident simplex; an undo.
   Holds: the invariants of >>mesh; incident[v] is a simplex that has v, PBW_NONE if v is hidden, or a code that says
   why v is in no simplex; the journal leads back to the triangulation at its start.

   The journal has each simplex as it was when it was first deleted.  Of two simplices that were neighbours at the
   start, the one that was deleted first has a link to the other.  A link is right, in both directions, if it leads to
   a facet with the same vertices; so all links can be restored once the corners are written back, in any order.

   A task of >>tasks has a core of its own.  Its members before `kernel` are copies of the main core's, with the same
   arrays; the members from `kernel` on belong to the task.
   ------------------------------------------------------------------------------------------------------ */
#define PBWL__VERTEX_PENDING (PBW_NONE - 1)          /* incident: a vertex that is to be inserted */
#define PBWL__VERTEX_REMOVED (PBW_NONE - 2)          /* incident: a vertex that was removed */
#define PBWL__UNSUITED ((pbw_status)14)              /* not carried out: another way serves every case */
#define PBWL__REBUILD ((pbw_status)13)               /* not carried out: triangulate all points again */

typedef struct pbwl__saved { pbw_index slot, corner[4]; pbw__link link[4]; } pbwl__saved;    /* before its deletion */

/* A facet of the hole, open or closed.  v: its vertices, as indices in link_vertex; (apex, v[0], v[1], v[2]) is
   positive for an apex in the hole.  across: the facet of a simplex outside of the hole, or, if is_new, 4 * its index
   in new_simplex + corner. */
typedef struct pbwl__hole_facet {
    uint64_t key;
    pbw_index v[3];
    unsigned char is_new, closed;
    pbw__link across;
} pbwl__hole_facet;

typedef struct pbwl__new_simplex { pbw_index v[4]; pbw__link link[4]; unsigned char is_new[4]; } pbwl__new_simplex;

/* The facets of the hole of v, see >>ears.  Corner 4 i + k is corner k of the i-th simplex of the star; that of v
   itself is not used.  Each edge is opposite to two corners.  A hole with n vertices has 2 n - 4 facets and 3 n - 6
   edges. */
#define PBWL__MOST_EARS 60
#define PBWL__NEW_EARS 92                            /* 90 edges at most; 91: no edge; 92: the first new time */
#define PBWL__MOST_NEW 128
typedef struct pbwl__ears {
    double row[PBWL__MOST_EARS / 2 + 3][4];          /* per vertex of link_vertex: its point relative to v; lift */
    double low[PBWL__NEW_EARS + 4];                  /* per edge: the interval of its time, from low to high; then */
    double high[PBWL__NEW_EARS + 4];                 /* four new times */
    double spare;                                    /* the largest height - lift */
    pbw__link across[PBWL__MOST_EARS];               /* per facet, as in pbwl__hole_facet */
    unsigned char is_new[PBWL__MOST_EARS];
    unsigned char vertex[4 * PBWL__MOST_EARS];       /* per corner: its vertex; the next one of the facet; that */
    unsigned char next[4 * PBWL__MOST_EARS];         /* across the edge opposite to it; this edge */
    unsigned char opposite[4 * PBWL__MOST_EARS], edge[4 * PBWL__MOST_EARS];
    unsigned char seed[PBWL__MOST_EARS + 1];         /* per facet: the corner from which it was met */
    unsigned char corner[PBWL__NEW_EARS + 4];        /* per edge, and per new time: a corner opposite to it */
    unsigned char updated[4];                        /* per new time: the edge */
    unsigned char degree[PBWL__MOST_EARS / 2 + 3];   /* per vertex: its facets */
    unsigned facets, edges;
} pbwl__ears;

typedef struct pbwl__core {
    pbw__store store;
    pbw__grid grid;
    double low[4], high[4];                          /* the box of the records that the grid was made for */
    double *record;                                  /* per vertex, as in >>order */
    pbw_index *name, *incident, *link_index;         /* per vertex: its number for the caller; a simplex; its index in
                                                        link_vertex, if it is there */
    pbw_index *neighbor;                             /* per vertex to be inserted: a vertex near it; 0: none */
    pbw_index *vertex, *twin;                        /* per number: its vertex; the next number at the same point */
    pbw_index *place;                                /* a hash table of vertices by coordinates; 0: empty.  Removed
                                                        and moved vertices may still have old entries */
    pbw_index *unused, *hidden, *container;          /* vertices; container: a simplex that contains hidden[i] */
    pbw_index *next_hidden, *next_container;         /* hidden and container after the commit */
    pbw_index *start;                                /* per cell of a grid: a vertex that is or was there; 0: none */
    double start_low[3], start_scale[3];
    size_t start_side, searched;                     /* cells along an axis; walks since it was made */
    size_t record_capacity, name_capacity, incident_capacity, link_index_capacity, neighbor_capacity, vertex_capacity;
    size_t twin_capacity, start_capacity, place_capacity, unused_capacity, hidden_capacity, container_capacity;
    size_t next_hidden_capacity, next_container_capacity, touched_capacity;
    size_t vertex_count, unused_count, hidden_count, next_hidden_count, placed, duplicate_count, saved_simplices;
    unsigned char *touched;                          /* per slot: 1 if it is in a journal */
    int sorted;                                      /* the vertices are in the order of a build of them */
    struct pbwl__core **task;                        /* >>tasks */
    size_t task_capacity, tasks;
    /* owned by one thread from here on */
    pbw__kernel kernel;
    size_t simplex_count;                            /* a task's: the change of the count */
    /* scratch to remove one vertex */
    pbw_index *link_vertex, *table;                  /* table: a hash table of hole_facet by keys; 1 + index */
    pbwl__hole_facet *hole_facet;
    pbwl__new_simplex *new_simplex;
    size_t link_vertex_capacity, table_capacity, hole_facet_capacity, new_simplex_capacity;
    size_t link_vertices, hole_facets, new_simplices, effort, reinserted, handled;   /* handled: changes of a round */
    pbwl__ears ears;
    /* the journal */
    pbwl__saved *saved;
    pbw_index *used_slot;                            /* slots that were free */
    pbw__link *edge, *untested;                      /* edges to test, see >>verify; still to test, see >>moves */
    size_t saved_capacity, used_slot_capacity, edge_capacity, untested_capacity;
    size_t saved_count, used_slot_count, untested_count;
    int inserting;                                   /* a weighted point, which may hide others */
} pbwl__core;

/* Frees the members that one thread owns. */
static void pbwl__core_free_own(pbw__context *context, pbwl__core *core)
{
    pbw_memory *memory = &context->memory;
    core->kernel.context = context;
    pbw__kernel_free(&core->kernel);
    PBW__RELEASE(memory, core, link_vertex);
    PBW__RELEASE(memory, core, table);
    PBW__RELEASE(memory, core, hole_facet);
    PBW__RELEASE(memory, core, new_simplex);
    PBW__RELEASE(memory, core, saved);
    PBW__RELEASE(memory, core, used_slot);
    PBW__RELEASE(memory, core, edge);
    PBW__RELEASE(memory, core, untested);
}

static void pbwl__core_free(pbw__context *context, pbwl__core *core)
{
    pbw_memory *memory = &context->memory;
    pbwl__core_free_own(context, core);
    while (core->tasks > 0) {
        pbwl__core_free_own(context, core->task[--core->tasks]);
        pbw__release(memory, core->task[core->tasks], 1, sizeof(pbwl__core));
    }
    PBW__RELEASE(memory, core, task);
    pbw__store_free(memory, &core->store);
    PBW__RELEASE(memory, core, record);
    PBW__RELEASE(memory, core, name);
    PBW__RELEASE(memory, core, incident);
    PBW__RELEASE(memory, core, link_index);
    PBW__RELEASE(memory, core, neighbor);
    PBW__RELEASE(memory, core, vertex);
    PBW__RELEASE(memory, core, twin);
    PBW__RELEASE(memory, core, place);
    PBW__RELEASE(memory, core, start);
    PBW__RELEASE(memory, core, unused);
    PBW__RELEASE(memory, core, hidden);
    PBW__RELEASE(memory, core, container);
    PBW__RELEASE(memory, core, next_hidden);
    PBW__RELEASE(memory, core, next_container);
    PBW__RELEASE(memory, core, touched);
    memset(core, 0, sizeof(*core));
}

#define PBWL__CORE_GROW(core, x, needed) PBW__GROW(&(core)->kernel, core, x, needed)

PBW__INLINE const double *pbwl__core_record(const pbwl__core *core, pbw_index v)
{
    return core->record + (size_t)v * ((size_t)core->kernel.dim + 1);
}

/* Returns whether this task owns a vertex, claiming it if it is free; always if there are no tasks.  See >>tasks. */
PBW__INLINE int pbwl__hold(pbw__kernel *kernel, pbw_index v)
{
    return kernel->own.owner == NULL || v == PBW__GHOST || pbw__owns_zone(kernel, v);
}

PBW__INLINE int pbwl__hold_corners(pbw__kernel *kernel, size_t t)
{
    const pbw_index *v = kernel->corner + 4 * t;
    const int dim = kernel->dim;
    int k;
    if (kernel->own.owner == NULL || (pbw__is_ours(kernel, v[0]) & pbw__is_ours(kernel, v[1])
                                      & pbw__is_ours(kernel, v[2]) & pbw__is_ours(kernel, v[dim]))) {
        return 1;
    }
    for (k = 0; k <= dim && pbwl__hold(kernel, v[k]); k++) {
    }
    return k > dim;
}

/* Returns the status for a missing slot: a task may get one in a later round. */
PBW__INLINE pbw_status pbwl__no_room(const pbw__kernel *kernel, pbw_status status)
{
    return status == PBW__DEFERRED && kernel->own.owner == NULL ? PBW_ERROR_TOO_LARGE : status;
}

PBW__INLINE unsigned pbwl__corner_at(const pbw_index *corner, pbw_index v)
{
    unsigned k = 0;
    while (corner[k] != v) {
        k++;
    }
    return k;
}

/* Sets facet to a, b, c, the facet opposite to corner i of a positive simplex v: (v[i], a, b, c) is positive. */
PBW__INLINE void pbwl__facet_of(const pbw_index *v, unsigned i, int dim, pbw_index *facet)
{
    if (dim == 2) {
        facet[0] = v[i == 2 ? 0 : i + 1];
        facet[1] = v[i == 0 ? 2 : i - 1];
        facet[2] = PBW_NONE;
    } else {
        facet[0] = v[pbw__facet_corners[i][1]];
        facet[1] = v[pbw__facet_corners[i][2]];
        facet[2] = v[pbw__facet_corners[i][3]];
    }
}

/* Returns whether facet j of simplex u is facet k of simplex t: the same vertices in the opposite order. */
PBW__INLINE unsigned pbwl__facets_fit(const pbw_index *t, unsigned k, const pbw_index *u, unsigned j, int dim)
{
    pbw_index a[3], b[3];
    pbwl__facet_of(t, k, dim, a);
    pbwl__facet_of(u, j, dim, b);
    return dim == 2 ? (unsigned)((a[0] == b[1]) & (a[1] == b[0]))
                    : (unsigned)(((a[0] == b[0]) & (a[1] == b[2]) & (a[2] == b[1]))
                                 | ((a[0] == b[1]) & (a[1] == b[0]) & (a[2] == b[2]))
                                 | ((a[0] == b[2]) & (a[1] == b[1]) & (a[2] == b[0])));
}

/* ---- arrays by many threads */
/* pbw_memory_grow for arrays of all vertices: if there is room for both, all threads copy the old one. */
static int pbwl__grow_shared(pbw__context *context, void *array, size_t *capacity, size_t needed, size_t size)
{
    const size_t larger = *capacity + *capacity / 4 + 16, wanted = needed > larger ? needed : larger;
    void *old, *block = NULL;
    if (needed > *capacity && pbw__tasks(context, *capacity * size, 262144) > 1) {
        block = pbw__allocate_large(context, wanted, size);
    }
    if (block == NULL) {
        return pbw_memory_grow(&context->memory, array, capacity, needed, 0, size);
    }
    memcpy(&old, array, sizeof(old));
    pbw__set_or_copy(context, block, old, 0, *capacity * size);
    pbw__release(&context->memory, old, *capacity, size);
    memcpy(array, &block, sizeof(block));
    *capacity = wanted;
    return 1;
}
#define PBWL__GROW_SHARED(core, x, needed) \
    pbwl__grow_shared((core)->kernel.context, &(core)->x, &(core)->x##_capacity, needed, sizeof(*(core)->x))

/* Lists those of a range of items that are wanted, from index `at` of a list on, or only counts them if at is
   PBWL__COUNT.  Returns how many they are. */
typedef size_t pbwl__list_body(void *arg, size_t from, size_t to, size_t at);
#define PBWL__COUNT ((size_t)-1)
#define PBWL__MOST_SHARES 1024                       /* four for each of 256 threads */

typedef struct pbwl__listing {
    pbwl__list_body *body;
    void *arg;
    size_t count, first[PBWL__MOST_SHARES + 1];      /* first: per share, the index of its first item in the list */
    int tasks, counting;
} pbwl__listing;

static void pbwl__list_share(void *arg, int task)
{
    pbwl__listing *listing = (pbwl__listing *)arg;
    const size_t from = pbw__share(listing->count, task, listing->tasks);
    const size_t to = pbw__share(listing->count, task + 1, listing->tasks);
    if (listing->counting) {
        listing->first[task + 1] = listing->body(listing->arg, from, to, PBWL__COUNT);
    } else {
        (void)listing->body(listing->arg, from, to, listing->first[task]);
    }
}

/* Lists the wanted ones of `count` items in their order.  Returns how many they are. */
static size_t pbwl__list(pbw__context *context, size_t count, pbwl__list_body *body, void *arg)
{
    pbwl__listing listing;
    int i;
    listing.tasks = pbw__tasks(context, count, 4096);
    if (listing.tasks == 1) {
        return body(arg, 0, count, 0);
    }
    listing.body = body;
    listing.arg = arg;
    listing.count = count;
    listing.first[0] = 0;
    for (listing.counting = 1; listing.counting >= 0; listing.counting--) {
        pbw__for(context, listing.tasks, pbwl__list_share, &listing);
        for (i = 0; i < listing.tasks && listing.counting; i++) {
            listing.first[i + 1] += listing.first[i];
        }
    }
    return listing.first[listing.tasks];
}

/* ---- the journal */
/* Makes `touched` as long as the store; new entries are 0. */
static int pbwl__journal_reserve(pbwl__core *core)
{
    const size_t old = core->touched_capacity;
    if (core->store.capacity <= old) {
        return 1;
    }
    if (!PBWL__CORE_GROW(core, touched, core->store.capacity)) {
        return 0;
    }
    pbw__set_bytes(core->kernel.context, core->touched + old, 0, core->touched_capacity - old);
    return 1;
}

/* Returns the index of a vertex in link_vertex, where the ghost is the first; adds it if it is not there. */
static pbw_index pbwl__link_index(pbwl__core *core, pbw_index v)
{
    const pbw_index at = core->link_index[v];
    if (at < core->link_vertices && core->link_vertex[at] == v) {
        return at;
    }
    core->link_vertex[core->link_vertices] = v;
    return core->link_index[v] = (pbw_index)core->link_vertices++;
}

/* Notes the simplices of the cavity before they are deleted.  PBW__DEFERRED: not all of their corners are ours. */
static pbw_status pbwl__journal_cavity(pbw__kernel *kernel)
{
    pbwl__core *core = (pbwl__core *)kernel->journal;
    const size_t count = kernel->scratch.cavity_count;
    size_t i;
    for (i = 0; i < count && kernel->own.owner != NULL; i++) {
        if (!pbwl__hold_corners(kernel, kernel->scratch.cavity[i])) {
            return PBW__DEFERRED;
        }
    }
    if (!PBWL__CORE_GROW(core, saved, core->saved_count + count)
        || (core->inserting && !PBWL__CORE_GROW(core, link_vertex, 4 * count + 8))) {
        return PBW_ERROR_MEMORY;
    }
    core->link_vertices = core->inserting ? 0 : core->link_vertices;
    for (i = 0; i < count; i++) {
        const size_t t = kernel->scratch.cavity[i];
        int k;
        core->simplex_count -= kernel->corner[4 * t + (size_t)kernel->dim] != PBW__GHOST;
        for (k = 0; k <= kernel->dim && core->inserting; k++) {
            const pbw_index v = kernel->corner[4 * t + (size_t)k];
            if (v != PBW__GHOST) {
                core->incident[v] = PBW_NONE;        /* until it is in the star */
                (void)pbwl__link_index(core, v);
            }
        }
        if (!core->touched[t]) {
            pbwl__saved *saved = core->saved + core->saved_count++;
            core->touched[t] = 1;
            saved->slot = (pbw_index)t;
            memcpy(saved->corner, kernel->corner + 4 * t, sizeof(saved->corner));
            memcpy(saved->link, kernel->link + 4 * t, sizeof(saved->link));
        }
    }
    return PBW_OK;
}

/* Makes a new simplex, or if it is a ghost the finite one behind it, incident to its corners. */
static void pbwl__note_corners(pbwl__core *core, size_t t)
{
    const pbw__kernel *kernel = &core->kernel;
    const int dim = kernel->dim;
    const pbw_index *v = kernel->corner + 4 * t;
    const int finite = v[dim] != PBW__GHOST;
    const pbw_index incident = finite ? (pbw_index)t : (pbw_index)(kernel->link[4 * t + (size_t)dim] >> 2);
    int k;
    for (k = 0; k < dim + finite; k++) {
        core->incident[v[k]] = incident;
    }
    core->simplex_count += (size_t)finite;
}

/* Notes those slots of the new star that were free, before they are used. */
static pbw_status pbwl__journal_slots(pbw__kernel *kernel)
{
    pbwl__core *core = (pbwl__core *)kernel->journal;
    const size_t count = kernel->scratch.facet_count;
    size_t i;
    if (!pbwl__journal_reserve(core) || !PBWL__CORE_GROW(core, used_slot, core->used_slot_count + count)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < count; i++) {
        const size_t t = kernel->scratch.cavity[i];
        if (!core->touched[t]) {
            core->touched[t] = 1;
            core->used_slot[core->used_slot_count++] = (pbw_index)t;
        }
    }
    return PBW_OK;
}

/* Makes simplices of the new star incident to its vertices. */
static void pbwl__note_star(pbwl__core *core)
{
    size_t i;
    for (i = 0; i < core->kernel.scratch.facet_count; i++) {
        pbwl__note_corners(core, core->kernel.scratch.cavity[i]);
    }
}

/* Returns the number of finite simplices in the cavity. */
static size_t pbwl__count_finite(const pbw__kernel *kernel)
{
    size_t i, finite = 0;
    for (i = 0; i < kernel->scratch.cavity_count; i++) {
        finite += kernel->corner[4 * (size_t)kernel->scratch.cavity[i] + (size_t)kernel->dim] != PBW__GHOST;
    }
    return finite;
}

/* What a share of the slots has: a chain of free ones, and the last finite simplex. */
#define PBWL__MOST_SLOTS_SHARES 64
typedef struct pbwl__slots_share {
    size_t free_count, simplex_count;
    pbw_index list, last, finite;
} pbwl__slots_share;

typedef struct pbwl__slots_scan {
    pbwl__core *core;
    int incident, tasks;                             /* incident: find incident simplices, too */
    pbwl__slots_share share[PBWL__MOST_SLOTS_SHARES];
} pbwl__slots_scan;

PBW__INLINE void pbwl__scan_slots_of(pbwl__slots_scan *scan, int task, int dim)
{
    const pbw__kernel *kernel = &scan->core->kernel;
    const size_t count = scan->core->store.count, end = pbw__share(count, task + 1, scan->tasks);
    pbw_index *incident = scan->incident ? scan->core->incident : NULL;
    pbwl__slots_share share = { 0, 0, PBW_NONE, PBW_NONE, PBW_NONE };
    size_t t;
    int k;
    for (t = pbw__share(count, task, scan->tasks); t < end; t++) {
        pbw_index *corner = kernel->corner + 4 * t;
        kernel->mark[t] = 0;
        if (corner[0] == PBW_NONE) {
            corner[1] = share.list;
            share.list = (pbw_index)t;
            share.last = share.free_count++ == 0 ? (pbw_index)t : share.last;
        } else if (corner[dim] != PBW__GHOST) {
            share.simplex_count++;
            share.finite = (pbw_index)t;
            for (k = 0; k <= dim && incident != NULL; k++) {
                PBW__STORE(incident + corner[k], (pbw_index)t);
            }
        }
    }
    scan->share[task] = share;
}

static void pbwl__scan_slots_share(void *arg, int task)
{
    pbwl__slots_scan *scan = (pbwl__slots_scan *)arg;
    PBW__BY_DIM(scan->core->kernel.dim, pbwl__scan_slots_of, scan, task);
}

/* Makes the list of free slots again, and counts the simplices.  incident: makes simplices incident to their corners,
   too, any one of those at a vertex. */
static void pbwl__scan_slots(pbwl__core *core, int incident)
{
    pbw__kernel *kernel = &core->kernel;
    const int tasks = pbw__tasks(kernel->context, core->store.count, 16384);
    pbwl__slots_scan scan;
    size_t t;
    int i;
    for (t = 0; t <= core->tasks; t++) {
        pbw__slots *slots = &(t < core->tasks ? core->task[t] : core)->kernel.slots;
        slots->free_count = slots->tail = slots->tail_end = 0;
        slots->free_list = PBW_NONE;
    }
    scan.core = core;
    scan.incident = incident;
    scan.tasks = tasks < PBWL__MOST_SLOTS_SHARES ? tasks : PBWL__MOST_SLOTS_SHARES;
    pbw__for(kernel->context, scan.tasks, pbwl__scan_slots_share, &scan);
    core->simplex_count = 0;
    for (i = 0; i < scan.tasks; i++) {               /* the last is taken first: see >>change */
        const pbwl__slots_share *share = scan.share + i;
        core->simplex_count += share->simplex_count;
        kernel->last = share->finite != PBW_NONE ? share->finite : kernel->last;
        if (share->free_count > 0) {
            kernel->corner[4 * (size_t)share->last + 1] = kernel->slots.free_list;
            kernel->slots.free_last = kernel->slots.free_count == 0 ? share->last : kernel->slots.free_last;
            kernel->slots.free_list = share->list;
            kernel->slots.free_count += share->free_count;
        }
    }
}

/* Returns the core with the i-th journal: the main core, then its tasks. */
PBW__INLINE pbwl__core *pbwl__journal(pbwl__core *core, size_t i)
{
    return i == 0 ? core : core->task[i - 1];
}

/* Returns whether simplices were deleted. */
static int pbwl__journal_any(pbwl__core *core)
{
    size_t j;
    for (j = 0; j <= core->tasks && pbwl__journal(core, j)->saved_count == 0; j++) {
    }
    return j <= core->tasks;
}

static void pbwl__journal_clear_one(void *arg, int j)
{
    pbwl__core *core = (pbwl__core *)arg, *own = pbwl__journal(core, (size_t)j);
    size_t i;
    for (i = 0; i < own->saved_count; i++) {
        PBW__PREFETCH_TO_WRITE(core->touched + own->saved[i + 16 < own->saved_count ? i + 16 : i].slot);
        core->touched[own->saved[i].slot] = 0;
    }
    for (i = 0; i < own->used_slot_count; i++) {
        core->touched[own->used_slot[i]] = 0;
    }
    own->saved_count = own->used_slot_count = 0;
}

static void pbwl__journal_clear(pbwl__core *core)
{
    size_t count = 0, j;
    for (j = 0; j <= core->tasks; j++) {
        count += pbwl__journal(core, j)->saved_count;
    }
    if (count > PBW__SMALLER(16384)) {
        pbw__for(core->kernel.context, (int)core->tasks + 1, pbwl__journal_clear_one, core);
    } else {
        for (j = 0; j <= core->tasks; j++) {
            pbwl__journal_clear_one(core, (int)j);
        }
    }
    core->saved_simplices = core->simplex_count;
}

/* Sets the links of restored simplices. */
static void pbwl__journal_link(pbwl__core *core, const pbwl__saved *saved, size_t count)
{
    pbw__kernel *kernel = &core->kernel;
    const unsigned dim = (unsigned)kernel->dim;
    size_t i;
    unsigned k;
    for (i = 0; i < count; i++) {
        const size_t t = saved[i].slot;
        for (k = 0; k <= dim; k++) {
            const pbw__link to = saved[i].link[k];
            const pbw_index *u = kernel->corner + 4 * (size_t)(to >> 2);
            if (u[0] != PBW_NONE && pbwl__facets_fit(kernel->corner + 4 * t, k, u, (unsigned)(to & 3), (int)dim)) {
                kernel->link[4 * t + k] = to;
                kernel->link[to] = (pbw__link)(4 * t + k);
            }
        }
    }
}

/* Restores the triangulation at the start of the journal. */
static void pbwl__journal_undo(pbwl__core *core)
{
    pbw__kernel *kernel = &core->kernel;
    const int any = pbwl__journal_any(core);
    size_t i, j;
    for (j = 0; j <= core->tasks; j++) {
        const pbwl__core *own = pbwl__journal(core, j);
        for (i = 0; i < own->used_slot_count; i++) {
            kernel->corner[4 * (size_t)own->used_slot[i]] = PBW_NONE;
        }
        for (i = 0; i < own->saved_count; i++) {
            const pbwl__saved *saved = own->saved + i;
            memcpy(kernel->corner + 4 * (size_t)saved->slot, saved->corner, sizeof(saved->corner));
        }
    }
    for (j = 0; j <= core->tasks; j++) {
        pbwl__journal_link(core, pbwl__journal(core, j)->saved, pbwl__journal(core, j)->saved_count);
    }
    for (j = 0; j <= core->tasks; j++) {
        const pbwl__core *own = pbwl__journal(core, j);
        for (i = 0; i < own->saved_count; i++) {
            pbwl__note_corners(core, own->saved[i].slot);
        }
    }
    for (i = 0; i < core->hidden_count; i++) {
        core->incident[core->hidden[i]] = PBW_NONE;
    }
    if (any) {
        pbwl__scan_slots(core, 0);
    }
    core->simplex_count = core->saved_simplices;
    kernel->last = PBW_NONE;
    pbwl__journal_clear(core);
}
/* ------------------------------------------------------------------------------------------------------
   >>apex         The vertex behind a facet of a hole.
   In: the vertices of a link, a facet of the hole.  Out: the one of them that makes, with the facet, the
   simplex behind it, or none: see >>removal.
   Holds: every verdict is exact.

   Errors: see >>predicates, which also decides what a bound does not.  A side, which is an orientation, and a
   conflict are compared as squares with the square of the bound; h, the largest height of the rows, is raised to
   1e-55.  The determinant of a conflict is that of >>cavity3 or >>cavity2 with the last corner as the origin: a
   product has 6 roundings for the lift, 4 for its minor, 3 for their product and sums, 2 for the coordinate that
   this multiplies, 3 for the last sums; in the plane 5 for the lift, 1 for the coordinate beside it, 2, 2 and 2.  An
   infinite limit decides nothing.
   ------------------------------------------------------------------------------------------------------ */
/* A finite simplex with its last corner as the origin: its orientation, and the plane through its lifted corners,
   lift * orientation = normal . x.  Points with lifts below it are in conflict. */
typedef struct pbwl__plane { double origin[4], normal[3], orientation, height; } pbwl__plane;

/* Sets row to x relative to the origin, then its lift.  Returns its height. */
PBW__INLINE double pbwl__plane_row(const pbwl__plane *plane, const double *x, int dim, double *row)
{
    const double weight = x[dim] - plane->origin[dim];
    double square = 0.0;
    int k;
    for (k = 0; k < dim; k++) {
        row[k] = x[k] - plane->origin[k];
        square += row[k] * row[k];
    }
    row[dim] = square - weight;
    return square + pbw__abs(weight);
}

PBW__INLINE double pbwl__row_dot(const double *a, const double *b, int dim)
{
    return dim == 2 ? a[0] * b[0] + a[1] * b[1] : a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

PBW__INLINE void pbwl__cross_row(const double *a, const double *b, double *x)
{
    x[0] = a[1] * b[2] - a[2] * b[1];
    x[1] = a[2] * b[0] - a[0] * b[2];
    x[2] = a[0] * b[1] - a[1] * b[0];
}

/* Sets normal to that of the facet of rows a and b and the origin, towards apexes of positive simplices. */
PBW__INLINE void pbwl__facet_normal(const double *a, const double *b, int dim, double *normal)
{
    if (dim == 2) {
        normal[0] = a[1];
        normal[1] = -a[0];
        normal[2] = 0.0;
    } else {
        pbwl__cross_row(b, a, normal);
    }
}

/* Sets the plane of the rows a, b and c and the origin; normal: that of the facet of b and c. */
PBW__INLINE void pbwl__plane_set(pbwl__plane *plane, const double *a, const double *b, const double *c,
                                 const double *normal, int dim)
{
    double ac[3], ba[3];
    int k;
    plane->orientation = pbwl__row_dot(a, normal, dim);
    if (dim == 2) {
        plane->normal[0] = a[2] * b[1] - b[2] * a[1];
        plane->normal[1] = b[2] * a[0] - a[2] * b[0];
        plane->normal[2] = 0.0;
        return;
    }
    pbwl__cross_row(a, c, ac);
    pbwl__cross_row(b, a, ba);
    for (k = 0; k < 3; k++) {
        plane->normal[k] = a[3] * normal[k] + b[3] * ac[k] + c[3] * ba[k];
    }
}

PBW__INLINE void pbwl__plane_of(const pbwl__core *core, const pbw_index *v, int dim, pbwl__plane *plane)
{
    double row[3][4], normal[3], height = 1e-55;
    int i;
    for (i = 0; i <= dim; i++) {
        plane->origin[i] = core->record[v[dim] * ((size_t)dim + 1) + (size_t)i];
    }
    for (i = 0; i < dim; i++) {
        height = pbw__max(height, pbwl__plane_row(plane, core->record + v[i] * ((size_t)dim + 1), dim, row[i]));
    }
    plane->height = height;
    pbwl__facet_normal(row[1], row[2], dim, normal);
    pbwl__plane_set(plane, row[0], row[1], row[2], normal, dim);
}

/* Return the squares of the bounds of a side and of a conflict. */
PBW__INLINE double pbwl__side_limit(double h, int dim)
{
    return h * h * (dim == 2 ? PBW__ORIENT2_ERROR * PBW__ORIENT2_ERROR
                             : h * (PBW__ORIENT3_ERROR * PBW__ORIENT3_ERROR));
}

PBW__INLINE double pbwl__conflict_limit(double h, int dim)
{
    return h * h * (h * h) * (dim == 2 ? PBW__CIRCLE_ERROR * PBW__CIRCLE_ERROR
                                       : h * (PBW__SPHERE_ERROR * PBW__SPHERE_ERROR));
}

/* Returns whether e is strictly on the hole's side of the facet v of the hole; side: its product with the
   normal of the facet. */
PBW__INLINE int pbwl__facet_sees(const pbwl__core *core, const pbw_index *v, pbw_index e, double side, double height,
                                 int dim)
{
    const double *x[4] = { NULL, NULL, NULL, NULL };
    int k;
    if (PBW__LIKELY(side * side > pbwl__side_limit(height, dim))) {
        return side > 0.0;
    }
    x[0] = pbwl__core_record(core, e);
    for (k = 0; k < dim; k++) {
        x[k + 1] = pbwl__core_record(core, v[k]);
    }
    return pbw__orient(dim, x, &core->grid) > 0;
}

/* Returns whether e is in conflict with the simplex of these corners and this plane; row: e's, then its height. */
PBW__INLINE int pbwl__plane_conflict(const pbwl__core *core, const pbwl__plane *plane, const pbw_index *corner,
                                     pbw_index e, const double *row, int dim)
{
    const double det = pbwl__row_dot(row, plane->normal, dim) - row[dim] * plane->orientation;
    const double limit = pbwl__conflict_limit(pbw__max(plane->height, row[4]), dim);
    const double *p = pbwl__core_record(core, e), *x[4] = { NULL, NULL, NULL, NULL };
    int k;
    if (PBW__LIKELY(det * det > limit)) {
        return det > 0.0;
    }
    for (k = 0; k <= dim; k++) {
        x[k] = pbwl__core_record(core, corner[k]);
    }
    return pbw__conflict(dim, x, p, &core->grid);
}

/* Returns the apex behind a facet of the hole, by a tournament; 0, the ghost's index, if there is none. */
PBW__INLINE pbw_index pbwl__facet_apex(const pbwl__core *core, const pbw_index *hole_facet, int dim)
{
    const pbw_index *u = core->link_vertex;
    pbw_index corner[4] = { 0, u[hole_facet[0]], u[hole_facet[1]], dim == 3 ? u[hole_facet[2]] : 0 }, i, apex = 0;
    pbwl__plane plane;
    double a[4], b[4] = { 0.0, 0.0, 0.0, 0.0 }, normal[3], row[5], height;
    memset(&plane, 0, sizeof(plane));
    memcpy(plane.origin, pbwl__core_record(core, corner[dim]), ((size_t)dim + 1) * sizeof(double));
    height = pbw__max(1e-55, pbwl__plane_row(&plane, pbwl__core_record(core, corner[1]), dim, a));
    if (dim == 3) {
        height = pbw__max(height, pbwl__plane_row(&plane, pbwl__core_record(core, corner[2]), dim, b));
    }
    pbwl__facet_normal(a, b, dim, normal);
    for (i = 1; i < core->link_vertices; i++) {
        if (i == hole_facet[0] || i == hole_facet[1] || i == hole_facet[2]) {
            continue;
        }
        row[4] = pbwl__plane_row(&plane, core->record + u[i] * ((size_t)dim + 1), dim, row);
        if (pbwl__facet_sees(core, corner + 1, u[i], pbwl__row_dot(row, normal, dim), pbw__max(height, row[4]), dim)
            && (apex == 0 || pbwl__plane_conflict(core, &plane, corner, u[i], row, dim))) {
            apex = i;
            corner[0] = u[i];
            pbwl__plane_of(core, corner, dim, &plane);
        }
    }
    return apex;
}

/* ------------------------------------------------------------------------------------------------------
   >>ears         The hole of a vertex in space, cut off ear by ear.
   In: a vertex v inside the hull.  Out: its star in scratch.cavity, its link in link_vertex, the simplices that fill
   the hole in new_simplex; or PBWL__UNSUITED: rounded numbers leave them uncertain, or there are too many facets.
   Holds: every verdict is exact.

   Let the lift of v rise by t, from 0 on, while all others stay.  The regular triangulation changes by flips in the
   star of v, until a last simplex hides v; the simplices without v that the flips make fill the hole.  Two facets abc
   and bad of the hole meet in the edge ab; behind it is the facet vab of the star.  This facet is regular until the
   lifts of v, a, b, c and d are in one plane, at t = P / Q: Q is the orientation of (d, a, b, c), P the power
   determinant of (v, a, b, c) and d.  It stays regular if Q < 0.  So the edge with the least time is flipped next,
   which makes the simplex dabc.  If only three facets meet in a, the facet dbc replaces them, and likewise at b;
   otherwise cad and dbc replace abc and bad.  The last simplex is between four facets.

   Each time has an error interval.  The edges at a vertex of three facets have one and the same time.  If the
   interval of any other edge overlaps the least one, the order is uncertain.  This covers flips of four vertices in a
   plane, where two edges have one time.  Tie-breaking changes a time by less than the gap between any two intervals.
   ------------------------------------------------------------------------------------------------------ */
#ifdef PBW__SIMD
PBW__OPERATION(pbw__d4, pbwl__sqrt4, (pbw__d4 x),
    _mm256_sqrt_pd(x), pbw__join(vsqrtq_f64(pbw__half(x, 0)), vsqrtq_f64(pbw__half(x, 1))))

PBW__SIMD_INLINE unsigned pbwl__lane_of(unsigned set)         /* the first lane of a set */
{
    return (unsigned)__builtin_ctz(set | 8);
}

/* The intervals of the times of four edges; both ends are infinite for an edge without a time. */
typedef struct pbwl__spans4 { pbw__d4 low, high; } pbwl__spans4;

PBW__SIMD_INLINE pbwl__spans4 pbwl__ear_spans(const pbw__d4 *a, const pbw__d4 *b, const pbw__d4 *c, const pbw__d4 *d,
                                              pbw__d4 spare)
{
    const pbw__d4 ab = pbw__det2(a[0], a[1], b[0], b[1]), ac = pbw__det2(a[0], a[1], c[0], c[1]);
    const pbw__d4 ad = pbw__det2(a[0], a[1], d[0], d[1]), bc = pbw__det2(b[0], b[1], c[0], c[1]);
    const pbw__d4 bd = pbw__det2(b[0], b[1], d[0], d[1]), cd = pbw__det2(c[0], c[1], d[0], d[1]);
    const pbw__d4 abc = pbw__fma(c[2], ab, pbw__fnma(b[2], ac, a[2] * bc));
    const pbw__d4 abd = pbw__fma(d[2], ab, pbw__fnma(b[2], ad, a[2] * bd));
    const pbw__d4 acd = pbw__fma(d[2], ac, pbw__fnma(c[2], ad, a[2] * cd));
    const pbw__d4 bcd = pbw__fma(d[2], bc, pbw__fnma(c[2], bd, b[2] * cd));
    const pbw__d4 h = pbw__max4(pbw__max4(a[3], b[3]), pbw__max4(c[3], d[3])) + spare, h3 = h * pbwl__sqrt4(h);
    const pbw__d4 side = (abc - abd) + (acd - bcd), side_error = h3 * pbw__splat(PBW__EAR_ERROR);
    const pbw__d4 power = pbw__fnma(c[3], abd, d[3] * abc) + pbw__fnma(a[3], bcd, b[3] * acd);
    const pbw__d4 power_error = h3 * h * pbw__splat(PBW__SPHERE_ERROR), inverse = pbw__splat(1.0) / side;
    const pbw__d4 t = power * inverse;
    const pbw__d4 error = pbw__fma(pbw__abs4(t), side_error, power_error) * (inverse * pbw__splat(PBW__TIME_ERROR));
    const pbw__d4 none = pbw__greater(pbw__splat(0.0) - side_error, side);
    pbwl__spans4 spans = { t - error, t + error };
    pbw__d4 sure = pbw__greater(side, side_error * pbw__splat(PBW__TIME_LEAST));
    sure = pbw__and4(sure, pbw__greater(pbw__splat(HUGE_VAL), spans.high));
    spans.low = pbw__blend(pbw__blend(pbw__splat(-HUGE_VAL), spans.low, sure), pbw__splat(HUGE_VAL), none);
    return spans;
}

PBW__INLINE const double *pbwl__ear_row(const pbwl__ears *ears, unsigned corner)
{
    return ears->row[ears->vertex[corner]];
}

PBW__SIMD_INLINE void pbwl__ear_columns(const double *a, const double *b, const double *c, const double *d,
                                        pbw__d4 *x)
{
    pbw__columns(a, b, c, d, x, x + 1);
    pbw__columns(a + 2, b + 2, c + 2, d + 2, x + 2, x + 3);
}

/* Computes the times of edges e to e + 3. */
PBW__SIMD_INLINE void pbwl__ear_times(pbwl__ears *ears, unsigned e)
{
    const unsigned a0 = ears->corner[e], a1 = ears->corner[e + 1], a2 = ears->corner[e + 2], a3 = ears->corner[e + 3];
    const unsigned b0 = ears->next[a0], b1 = ears->next[a1], b2 = ears->next[a2], b3 = ears->next[a3];
    const unsigned c0 = ears->next[b0], c1 = ears->next[b1], c2 = ears->next[b2], c3 = ears->next[b3];
    const unsigned d0 = ears->opposite[a0], d1 = ears->opposite[a1], d2 = ears->opposite[a2], d3 = ears->opposite[a3];
    pbw__d4 a[4], b[4], c[4], d[4];
    pbwl__spans4 spans;
    pbwl__ear_columns(ears->row[ears->vertex[a0]], ears->row[ears->vertex[a1]], ears->row[ears->vertex[a2]],
                      ears->row[ears->vertex[a3]], a);
    pbwl__ear_columns(ears->row[ears->vertex[b0]], ears->row[ears->vertex[b1]], ears->row[ears->vertex[b2]],
                      ears->row[ears->vertex[b3]], b);
    pbwl__ear_columns(ears->row[ears->vertex[c0]], ears->row[ears->vertex[c1]], ears->row[ears->vertex[c2]],
                      ears->row[ears->vertex[c3]], c);
    pbwl__ear_columns(ears->row[ears->vertex[d0]], ears->row[ears->vertex[d1]], ears->row[ears->vertex[d2]],
                      ears->row[ears->vertex[d3]], d);
    spans = pbwl__ear_spans(a, b, c, d, pbw__splat(ears->spare));
    memcpy(ears->low + e, &spans.low, sizeof(spans.low));
    memcpy(ears->high + e, &spans.high, sizeof(spans.high));
}

/* Joins facet k of new simplex f to the facet of a corner, across which it lies. */
PBW__INLINE void pbwl__ear_glue(pbwl__core *core, unsigned corner, unsigned f, unsigned k)
{
    const pbw__link across = core->ears.across[corner >> 2];
    const unsigned made = core->ears.is_new[corner >> 2];
    pbwl__new_simplex *other = core->new_simplex + (made ? across >> 2 : PBWL__MOST_NEW);   /* it, or a dummy */
    core->new_simplex[f].link[k] = across;
    core->new_simplex[f].is_new[k] = (unsigned char)made;
    other->link[across & 3] = 4 * f + k;
    other->is_new[across & 3] = 1;
}

/* Makes facet k of new simplex f the facet of a corner. */
PBW__INLINE void pbwl__ear_open(pbwl__ears *ears, unsigned corner, unsigned f, unsigned k)
{
    ears->across[corner >> 2] = 4 * f + k;
    ears->is_new[corner >> 2] = 1;
}

/* Makes e the edge opposite to corner p, with corner q on its other side. */
PBW__INLINE void pbwl__ear_join(pbwl__ears *ears, unsigned p, unsigned q, unsigned e)
{
    ears->opposite[p] = (unsigned char)q;
    ears->opposite[q] = (unsigned char)p;
    ears->edge[p] = ears->edge[q] = (unsigned char)e;
    ears->corner[e] = (unsigned char)p;
}

/* Notes that the edge opposite to corner p gets time k of the four new ones. */
PBW__INLINE void pbwl__ear_renew(pbwl__ears *ears, unsigned p, unsigned k)
{
    ears->corner[PBWL__NEW_EARS + k] = (unsigned char)p;
    ears->updated[k] = ears->edge[p];
    ears->low[ears->edge[p]] = HUGE_VAL;
}

/* Makes a new simplex of the vertices at four corners.  Returns its index. */
PBW__INLINE unsigned pbwl__ear_make(pbwl__core *core, unsigned a, unsigned b, unsigned c, unsigned d)
{
    pbwl__new_simplex *new_simplex = core->new_simplex + core->new_simplices;
    new_simplex->v[0] = core->ears.vertex[a];
    new_simplex->v[1] = core->ears.vertex[b];
    new_simplex->v[2] = core->ears.vertex[c];
    new_simplex->v[3] = core->ears.vertex[d];
    return (unsigned)core->new_simplices++;
}

/* Cuts off the edge opposite to corner c, between c and d: facets (c, a, b) and (d, b, a) become (c, a, d) and
   (d, b, c).  Returns the new times. */
PBW__SIMD_INLINE pbwl__spans4 pbwl__ear_flip(pbwl__core *core, unsigned c)
{
    pbwl__ears *ears = &core->ears;
    const unsigned a = ears->next[c], b = ears->next[a], d = ears->opposite[c], other_b = ears->next[d];
    const unsigned other_a = ears->next[other_b], e = ears->edge[c];
    const unsigned ad = ears->opposite[other_b], ca = ears->opposite[b], bc = ears->opposite[a];
    const unsigned db = ears->opposite[other_a];
    const double *at_a = pbwl__ear_row(ears, a), *at_b = pbwl__ear_row(ears, b);
    const double *at_c = pbwl__ear_row(ears, c), *at_d = pbwl__ear_row(ears, d);
    pbw__d4 x[4][4];
    pbwl__spans4 spans;
    unsigned f;
    pbwl__ear_columns(at_a, at_a, at_b, at_b, x[0]);
    pbwl__ear_columns(at_d, at_d, at_c, at_c, x[1]);
    pbwl__ear_columns(at_c, at_c, at_d, at_d, x[2]);
    pbwl__ear_columns(pbwl__ear_row(ears, ad), pbwl__ear_row(ears, ca), pbwl__ear_row(ears, bc),
                      pbwl__ear_row(ears, db), x[3]);
    spans = pbwl__ear_spans(x[0], x[1], x[2], x[3], pbw__splat(ears->spare));
    f = pbwl__ear_make(core, d, c, a, b);
    pbwl__ear_glue(core, c, f, 0);
    pbwl__ear_glue(core, d, f, 1);
    pbwl__ear_open(ears, d, f, 2);
    pbwl__ear_open(ears, c, f, 3);
    ears->degree[ears->vertex[a]]--;
    ears->degree[ears->vertex[b]]--;
    ears->degree[ears->vertex[c]]++;
    ears->degree[ears->vertex[d]]++;
    ears->vertex[b] = ears->vertex[d];
    ears->vertex[other_a] = ears->vertex[c];
    ears->low[e] = HUGE_VAL;
    pbwl__ear_join(ears, c, ad, ears->edge[ad]);
    pbwl__ear_join(ears, d, bc, ears->edge[bc]);
    pbwl__ear_join(ears, a, other_b, e);
    pbwl__ear_renew(ears, c, 0);
    pbwl__ear_renew(ears, b, 1);
    pbwl__ear_renew(ears, d, 2);
    pbwl__ear_renew(ears, other_a, 3);
    return spans;
}

/* Cuts off the vertex at corner p, where three facets meet: (p, b, c), (p, c, d) and (p, d, b) become (d, b, c).
   Returns the new times; subtracts from *overlap the number of the three edges that may have a time up to `high`. */
PBW__SIMD_INLINE pbwl__spans4 pbwl__ear_cut(pbwl__core *core, unsigned p, double high, unsigned *overlap)
{
    pbwl__ears *ears = &core->ears;
    const unsigned b = ears->next[p], c = ears->next[b], d = ears->opposite[b], second_p = ears->next[d];
    const unsigned third_p = ears->next[ears->next[ears->opposite[c]]];
    const unsigned cd = ears->opposite[second_p], db = ears->opposite[third_p], bc = ears->opposite[p];
    const unsigned gone[3] = { ears->edge[b], ears->edge[c], ears->edge[ears->next[second_p]] };
    const double *at_b = pbwl__ear_row(ears, b), *at_c = pbwl__ear_row(ears, c), *at_d = pbwl__ear_row(ears, d);
    pbw__d4 x[4][4];
    pbwl__spans4 spans;
    unsigned f, k;
    pbwl__ear_columns(at_d, at_d, at_d, at_d, x[0]);
    pbwl__ear_columns(at_b, at_b, at_b, at_b, x[1]);
    pbwl__ear_columns(at_c, at_c, at_c, at_c, x[2]);
    pbwl__ear_columns(pbwl__ear_row(ears, bc), pbwl__ear_row(ears, cd), pbwl__ear_row(ears, db), at_b, x[3]);
    spans = pbwl__ear_spans(x[0], x[1], x[2], x[3], pbw__splat(ears->spare));
    spans.low[3] = HUGE_VAL;                         /* only three are new */
    f = pbwl__ear_make(core, d, p, b, c);
    pbwl__ear_glue(core, p, f, 0);
    pbwl__ear_glue(core, second_p, f, 2);
    pbwl__ear_glue(core, third_p, f, 3);
    pbwl__ear_open(ears, p, f, 1);
    for (k = 0; k < 3; k++) {
        *overlap -= ears->low[gone[k]] <= high;
        ears->low[gone[k]] = HUGE_VAL;
    }
    ears->degree[ears->vertex[b]]--;
    ears->degree[ears->vertex[c]]--;
    ears->degree[ears->vertex[d]]--;
    ears->vertex[p] = ears->vertex[d];
    pbwl__ear_join(ears, b, cd, ears->edge[cd]);
    pbwl__ear_join(ears, c, db, ears->edge[db]);
    ears->facets -= 2;
    pbwl__ear_renew(ears, p, 0);
    pbwl__ear_renew(ears, b, 1);
    pbwl__ear_renew(ears, c, 2);
    ears->updated[3] = PBWL__NEW_EARS - 1;
    return spans;
}

/* Returns the edge with the least time, or PBWL__NEW_EARS + k for the k-th new time.  *overlap: the number of edges
   that may have this time. */
PBW__SIMD_INLINE unsigned pbwl__ear_least(const pbwl__ears *ears, pbw__d4 updated, unsigned *overlap)
{
    pbw__d4 least = pbw__load4d(ears->low), number = pbw__splat(0.0), most = pbw__min_lane(updated);
    double at[4], new_least = pbw__first(most);
    unsigned i, set = pbw__signs(pbw__equal(updated, most)), e;
    for (i = 4; i < ears->edges; i += 4) {
        const pbw__d4 low = pbw__load4d(ears->low + i), less = pbw__greater(least, low);
        least = pbw__blend(least, low, less);
        number = pbw__blend(number, pbw__splat((double)i), less);
    }
    memcpy(at, &number, sizeof(at));
    most = pbw__min_lane(least);
    e = pbwl__lane_of(pbw__signs(pbw__equal(least, most)));
    e += (unsigned)at[e];
    e = new_least < pbw__first(most) ? PBWL__NEW_EARS + pbwl__lane_of(set) : e;
    most = pbw__splat(ears->high[e]);
    *overlap = pbw__count4(pbw__signs(pbw__at_least(most, updated)));
    for (i = 0; i < ears->edges; i += 4) {
        *overlap += pbw__count4(pbw__signs(pbw__at_least(most, pbw__load4d(ears->low + i))));
    }
    return e;
}

/* Fills the hole, ear by ear. */
PBW__SIMD static PBW__NOINLINE pbw_status pbwl__cut_ears(pbwl__core *core)
{
    pbwl__ears *ears = &core->ears;
    pbwl__spans4 spans = { pbw__splat(HUGE_VAL), pbw__splat(HUGE_VAL) };
    unsigned p = ears->corner[0], k, f;
    for (k = 0; k < ears->edges; k += 4) {
        pbwl__ear_times(ears, k);
    }
    for (k = ears->edges; k % 4 != 0; k++) {
        ears->low[k] = HUGE_VAL;
    }
    memset(ears->updated, PBWL__NEW_EARS - 1, sizeof(ears->updated));
    while (ears->facets > 4) {
        unsigned overlap, e, a;
        double high;
        memcpy(ears->low + PBWL__NEW_EARS, &spans.low, sizeof(spans.low));
        memcpy(ears->high + PBWL__NEW_EARS, &spans.high, sizeof(spans.high));
        e = pbwl__ear_least(ears, spans.low, &overlap);
        high = ears->high[e];
        if (!(ears->low[e] > -HUGE_VAL && ears->low[e] < HUGE_VAL) || core->new_simplices + 2 > PBWL__MOST_NEW) {
            return PBWL__UNSUITED;
        }
        for (k = 0; k < 4; k++) {
            ears->low[ears->updated[k]] = ears->low[PBWL__NEW_EARS + k];
            ears->high[ears->updated[k]] = ears->high[PBWL__NEW_EARS + k];
        }
        p = ears->corner[e];
        a = ears->next[p];
        if (ears->degree[ears->vertex[a]] != 3 && ears->degree[ears->vertex[ears->next[a]]] != 3) {
            spans = pbwl__ear_flip(core, p);
            overlap--;
        } else {
            p = ears->degree[ears->vertex[a]] == 3 ? a : ears->next[a];
            spans = pbwl__ear_cut(core, p, high, &overlap);
        }
        if (overlap != 0) {
            return PBWL__UNSUITED;
        }
    }
    f = pbwl__ear_make(core, ears->opposite[p], p, ears->next[p], ears->next[ears->next[p]]);
    pbwl__ear_glue(core, p, f, 0);
    for (k = 1; k < 4; k++) {
        pbwl__ear_glue(core, ears->opposite[p], f, k);
        p = ears->next[p];
    }
    return PBW_OK;
}

/* Lists the facet opposite to v of simplex i of scratch.cavity, and appends those of its neighbours at v that are not
   in the cavity yet. */
PBW__INLINE pbw_status pbwl__star_facet(pbwl__core *core, pbw_index v, size_t i)
{
    pbw__kernel *kernel = &core->kernel;
    pbwl__ears *ears = &core->ears;
    const pbw_index *corner = kernel->corner + 4 * (size_t)kernel->scratch.cavity[i];
    const pbw__link *link = kernel->link + 4 * (size_t)kernel->scratch.cavity[i];
    const unsigned at = (unsigned)((corner[1] == v) + 2 * (corner[2] == v) + 3 * (corner[3] == v));
    const unsigned char *around = pbw__facet_corners[at];
    unsigned here = (unsigned)(4 * i), k;
    size_t count = kernel->scratch.cavity_count;
    if (corner[3] == PBW__GHOST) {
        return PBWL__UNSUITED;
    }
    ears->across[i] = link[at];
    ears->is_new[i] = 0;
    for (k = 1; k < 4; k++) {
        ears->next[here + around[k]] = (unsigned char)(here + around[k < 3 ? k + 1 : 1]);
    }
    for (k = 1; k < 4; k++) {
        const pbw__link to = link[around[k]];
        const size_t next = (size_t)(to >> 2);
        const int fresh = kernel->mark[next] == 0;
        if (fresh && kernel->own.owner != NULL && !pbwl__hold(kernel, kernel->corner[to])) {
            kernel->scratch.cavity_count = count;
            return PBW__DEFERRED;
        }
        kernel->mark[next] = (unsigned char)(fresh ? count + 1 : kernel->mark[next]);
        kernel->scratch.cavity[count] = (pbw_index)next;
        ears->seed[count] = (unsigned char)(here + around[k]);
        count += (size_t)fresh;
        ears->opposite[here + around[k]] = (unsigned char)(4 * (kernel->mark[next] - 1u) + (unsigned)(to & 3));
        PBW__PREFETCH(kernel->corner + 4 * next);
        PBW__PREFETCH(kernel->link + 4 * next);
    }
    kernel->scratch.cavity_count = count;
    if (i > 0) {                                     /* it has two vertices of the simplex it was met from */
        const unsigned from = ears->seed[i], b = ears->next[from];
        here = ears->opposite[from];
        ears->vertex[here] = (unsigned char)pbwl__link_index(core, corner[here & 3]);
        ears->vertex[ears->next[ears->next[here]]] = ears->vertex[b];
        ears->vertex[ears->next[here]] = ears->vertex[ears->next[b]];
    } else {
        ears->seed[0] = ears->opposite[around[1]];
        for (k = 1; k < 4; k++) {
            ears->vertex[around[k]] = (unsigned char)pbwl__link_index(core, corner[around[k]]);
        }
    }
    return PBW_OK;
}

/* Collects the star of v and the facets of its hole. */
static pbw_status pbwl__list_star(pbwl__core *core, pbw_index v)
{
    pbw__kernel *kernel = &core->kernel;
    pbw_status status = PBW_OK;
    size_t i;
    kernel->scratch.cavity_count = 0;
    if (!pbwl__hold(kernel, v) || !pbwl__hold_corners(kernel, core->incident[v])) {
        return PBW__DEFERRED;
    }
    if (!pbw__grow_lists(kernel, PBWL__MOST_EARS + 8) || !PBWL__CORE_GROW(core, link_vertex, PBWL__MOST_EARS + 8)
        || !PBWL__CORE_GROW(core, new_simplex, PBWL__MOST_NEW + 1)) {
        return PBW_ERROR_MEMORY;
    }
    kernel->scratch.cavity[0] = core->incident[v];
    kernel->scratch.cavity_count = 1;
    kernel->mark[core->incident[v]] = 1;
    core->link_vertex[0] = PBW__GHOST;               /* core->link_index[PBW__GHOST] is always 0 */
    core->link_vertices = 1;
    core->new_simplices = 0;
    for (i = 0; i < kernel->scratch.cavity_count && status == PBW_OK; i++) {
        status = kernel->scratch.cavity_count > PBWL__MOST_EARS - 3 ? PBWL__UNSUITED : pbwl__star_facet(core, v, i);
    }
    return status;
}

/* Lists the edges of the hole; makes the rows of its vertices relative to v. */
static void pbwl__list_ears(pbwl__core *core, pbw_index v)
{
    pbwl__ears *ears = &core->ears;
    pbwl__plane plane;
    unsigned i, k, edges = 0;
    memcpy(plane.origin, pbwl__core_record(core, v), sizeof(plane.origin));
    ears->spare = 1e-55;
    for (i = 1; i < core->link_vertices; i++) {
        const double *x = core->record + 4 * (size_t)core->link_vertex[i];
        const double height = pbwl__plane_row(&plane, x, 3, ears->row[i]);
        ears->spare = pbw__max(ears->spare, height - ears->row[i][3]);
        ears->degree[i] = 0;
    }
    ears->facets = (unsigned)core->kernel.scratch.cavity_count;
    for (i = 0; i < ears->facets; i++) {
        unsigned p = ears->opposite[ears->seed[i]];
        for (k = 0; k < 3; k++) {
            const unsigned q = ears->opposite[p];
            ears->degree[ears->vertex[p]]++;
            if (p < q) {
                pbwl__ear_join(ears, p, q, edges++);
            }
            p = ears->next[p];
        }
    }
    ears->edges = edges;
    for (k = edges; k % 4 != 0; k++) {
        ears->corner[k] = ears->corner[0];
    }
}
#endif

/* ------------------------------------------------------------------------------------------------------
   >>removal      Removes or inserts one vertex.
   In: a core, a vertex to remove or to insert.  Out: the triangulation without it, or with it.
   Holds: the invariants of >>core.

   Removal fills the hole by gift wrapping.  Let N be the vertices of the link of v.  The triangulation without v has
   the same simplices outside of the star of v; inside it has those simplices of the triangulation of N that are in
   conflict with v: all vertices there are in N, and none of N is in conflict with them.  So behind a facet abc of the
   hole is the simplex abce: e is the vertex of N strictly on the hole's side such that no other one of these is in
   conflict with abce; the ghost, if there is none.  Ties are broken as everywhere, so e is unique, and all facets of
   the new simplices meet in pairs.  Time: the new simplices times the size of N; if that grows too large, all points
   are triangulated again.
   ------------------------------------------------------------------------------------------------------ */
#define PBWL__MOST_LINK ((size_t)1 << 21)            /* vertices of a link: three indices fit a key */

/* Returns the indices of a facet's vertices in ascending order, as a key; in the plane the third is above all. */
PBW__INLINE uint64_t pbwl__facet_key(const pbw_index *v, unsigned dim)
{
    const uint64_t a = v[0], b = v[1], c = dim == 3 ? v[2] : PBWL__MOST_LINK;
    const uint64_t least = a < b ? a : b, most = a < b ? b : a;
    const uint64_t low = c < least ? c : least, high = c > most ? c : most;
    return low | (a + b + c - low - high) << 21 | high << 42;
}

/* Returns the entry of the table that has, or would have, a facet with this key. */
PBW__INLINE size_t pbwl__facet_find(const pbwl__core *core, uint64_t key, size_t size)
{
    size_t at = pbw__hash_entry(key, size);
    while (core->table[at] != 0 && core->hole_facet[core->table[at] - 1].key != key) {
        at = (at + 1) & (size - 1);
    }
    return at;
}

/* Collects the star of v in scratch.cavity.  PBW__DEFERRED: not all of its vertices are ours.  The caller clears the
   marks of the cavity, on any status. */
PBW__INLINE pbw_status pbwl__collect_star(pbwl__core *core, pbw_index v, size_t dim)
{
    pbw__kernel *kernel = &core->kernel;
    pbw_index *cavity = kernel->scratch.cavity;
    size_t count = 1, i, k;
    kernel->scratch.cavity_count = 0;
    if (!pbwl__hold(kernel, v) || !pbwl__hold_corners(kernel, core->incident[v])) {
        return PBW__DEFERRED;
    }
    cavity[0] = core->incident[v];
    kernel->mark[cavity[0]] = 1;
    for (i = 0; i < count; i++) {
        const size_t t = cavity[i];
        kernel->scratch.cavity_count = count;
        if (count + dim + 8 > kernel->scratch.cavity_capacity && !pbw__grow_lists(kernel, count + dim + 8)) {
            return PBW_ERROR_MEMORY;
        }
        cavity = kernel->scratch.cavity;
        for (k = 0; k <= dim; k++) {
            const size_t next = kernel->link[4 * t + k] >> 2;
            if (kernel->corner[4 * t + k] != v && !kernel->mark[next]) {
                if (!pbwl__hold(kernel, kernel->corner[kernel->link[4 * t + k]])) {
                    kernel->scratch.cavity_count = count;
                    return PBW__DEFERRED;
                }
                kernel->mark[next] = 1;
                cavity[count++] = (pbw_index)next;
                PBW__PREFETCH(kernel->corner + 4 * next);
                PBW__PREFETCH(kernel->link + 4 * next);
            }
        }
    }
    kernel->scratch.cavity_count = count;
    return PBW_OK;
}

/* Collects the star of v in scratch.cavity, its link in link_vertex and hole_facet. */
static pbw_status pbwl__list_hole(pbwl__core *core, pbw_index v)
{
    pbw__kernel *kernel = &core->kernel;
    const unsigned dim = (unsigned)kernel->dim;
    pbw_status status = dim == 3 ? pbwl__collect_star(core, v, 3) : pbwl__collect_star(core, v, 2);
    const size_t count = kernel->scratch.cavity_count;
    size_t i;
    unsigned k;
    if (status == PBW_OK && (!PBWL__CORE_GROW(core, hole_facet, count)
                             || !PBWL__CORE_GROW(core, link_vertex, (count + 1) * dim + 8))) {
        status = PBW_ERROR_MEMORY;
    }
    if (status != PBW_OK) {
        (void)pbw__leave_cavity(kernel, count);
        return status;
    }
    core->link_vertex[0] = PBW__GHOST;               /* core->link_index[PBW__GHOST] is always 0 */
    core->link_vertices = 1;
    core->hole_facets = core->new_simplices = 0;
    for (i = 0; i < count; i++) {
        const size_t t = kernel->scratch.cavity[i];
        const unsigned at = pbwl__corner_at(kernel->corner + 4 * t, v);
        pbwl__hole_facet *hole_facet = core->hole_facet + core->hole_facets++;
        pbwl__facet_of(kernel->corner + 4 * t, at, (int)dim, hole_facet->v);
        for (k = 0; k < dim; k++) {
            hole_facet->v[k] = pbwl__link_index(core, hole_facet->v[k]);
        }
        hole_facet->key = pbwl__facet_key(hole_facet->v, dim);
        hole_facet->across = kernel->link[4 * t + at];
        hole_facet->is_new = hole_facet->closed = 0;
    }
    return PBW_OK;
}

/* Joins facet k of new simplex f to the facet of the hole with its vertices, or makes it an open one. */
static pbw_status pbwl__glue(pbwl__core *core, size_t f, unsigned k, size_t size)
{
    pbwl__new_simplex *new_simplex = core->new_simplex + f;
    const pbw__link here = (pbw__link)(4 * f + k);
    const unsigned dim = (unsigned)core->kernel.dim;
    pbw_index facet[3];
    pbwl__hole_facet *hole_facet;
    uint64_t key;
    size_t at;
    pbwl__facet_of(new_simplex->v, k, (int)dim, facet);
    key = pbwl__facet_key(facet, dim);
    at = pbwl__facet_find(core, key, size);
    if (core->table[at] == 0) {
        hole_facet = core->hole_facet + core->hole_facets++;
        hole_facet->key = key;
        hole_facet->v[0] = facet[dim == 2];          /* in the opposite order */
        hole_facet->v[1] = facet[dim == 3 ? 2 : 0];
        hole_facet->v[2] = facet[dim == 3 ? 1 : 2];
        hole_facet->is_new = 1;
        hole_facet->closed = 0;
        hole_facet->across = here;
        core->table[at] = (pbw_index)core->hole_facets;
        return PBW_OK;
    }
    hole_facet = core->hole_facet + (core->table[at] - 1);
    if (hole_facet->closed) {
        return PBWL__REBUILD;                        /* a third simplex at one facet: impossible */
    }
    hole_facet->closed = 1;
    new_simplex->link[k] = hole_facet->across;
    new_simplex->is_new[k] = hole_facet->is_new;
    if (hole_facet->is_new) {
        core->new_simplex[hole_facet->across >> 2].link[hole_facet->across & 3] = here;
        core->new_simplex[hole_facet->across >> 2].is_new[hole_facet->across & 3] = 1;
    }
    return PBW_OK;
}

/* Makes room for one more simplex and its facets; the table stays at most half full.  Returns the size of the table,
   0 if memory is short. */
static size_t pbwl__gift_wrap_room(pbwl__core *core, size_t size)
{
    size_t i;
    if (!PBWL__CORE_GROW(core, new_simplex, core->new_simplices + 1)
        || !PBWL__CORE_GROW(core, hole_facet, core->hole_facets + 4)) {
        return 0;
    }
    if (size >= 2 * (core->hole_facets + 4)) {
        return size;
    }
    for (size = 64; size < 4 * (core->hole_facets + 4); size *= 2) {
    }
    if (!PBWL__CORE_GROW(core, table, size)) {
        return 0;
    }
    memset(core->table, 0, size * sizeof(pbw_index));
    for (i = 0; i < core->hole_facets; i++) {
        core->table[pbwl__facet_find(core, core->hole_facet[i].key, size)] = (pbw_index)i + 1;
    }
    return size;
}

/* Fills the hole behind its open facets. */
static pbw_status pbwl__gift_wrap(pbwl__core *core)
{
    const unsigned dim = (unsigned)core->kernel.dim;
    size_t size = pbwl__gift_wrap_room(core, 0), i, f;
    pbw_status status = PBW_OK;
    unsigned k;
    if (core->link_vertices >= PBWL__MOST_LINK) {
        return PBWL__REBUILD;
    }
    for (i = 0; i < core->hole_facets && status == PBW_OK; i++) {
        const pbw_index *v = core->hole_facet[i].v;
        pbwl__new_simplex *new_simplex;
        pbw_index apex;
        if (core->hole_facet[i].closed || v[0] == 0 || v[1] == 0 || v[2] == 0) {
            continue;                                /* facets of the ghost are only matched */
        }
        size = pbwl__gift_wrap_room(core, size);
        if (size == 0) {
            return PBW_ERROR_MEMORY;
        }
        v = core->hole_facet[i].v;
        core->effort += core->link_vertices;
        apex = PBW__BY_DIM(core->kernel.dim, pbwl__facet_apex, core, v);
        f = core->new_simplices++;
        new_simplex = core->new_simplex + f;
        if (apex != 0) {
            new_simplex->v[0] = apex;
            new_simplex->v[1] = v[0];
            new_simplex->v[2] = v[1];
            new_simplex->v[3] = v[2];
        } else {                                     /* the ghost comes last */
            new_simplex->v[0] = v[0];
            new_simplex->v[1] = v[dim == 3 ? 2 : 1];
            new_simplex->v[2] = dim == 3 ? v[1] : 0;
            new_simplex->v[3] = 0;
        }
        for (k = 0; k <= dim && status == PBW_OK; k++) {
            status = pbwl__glue(core, f, k, size);
        }
    }
    for (i = 0; i < core->hole_facets && status == PBW_OK && size > 0; i++) {
        status = core->hole_facet[i].closed ? PBW_OK : PBWL__REBUILD;
    }
    return size == 0 ? PBW_ERROR_MEMORY : status;
}

/* Writes the new simplices to slots. */
static void pbwl__fill_hole(pbwl__core *core)
{
    pbw__kernel *kernel = &core->kernel;
    const unsigned dim = (unsigned)kernel->dim;
    const pbw_index *slot = kernel->scratch.cavity;
    size_t f;
    unsigned k;
    for (f = 0; f < core->new_simplices; f++) {
        const pbwl__new_simplex *new_simplex = core->new_simplex + f;
        const size_t t = slot[f];
        kernel->mark[t] = 0;
        for (k = 0; k <= dim; k++) {
            const pbw__link to = new_simplex->link[k];
            kernel->corner[4 * t + k] = core->link_vertex[new_simplex->v[k]];
            if (new_simplex->is_new[k]) {
                kernel->link[4 * t + k] = (pbw__link)slot[to >> 2] * 4 + (to & 3);
            } else {
                kernel->link[4 * t + k] = to;
                kernel->link[to] = (pbw__link)(4 * t + k);
            }
        }
    }
}

/* Fills the hole by >>ears. */
static PBW__NOINLINE pbw_status pbwl__ear_hole(pbwl__core *core, pbw_index v)
{
    pbw_status status = PBWL__UNSUITED;
#ifdef PBW__SIMD
    if (core->kernel.dim == 3 && pbw__simd_works()) {
        status = pbwl__list_star(core, v);
        if (status == PBW_OK) {
            pbwl__list_ears(core, v);
            status = pbwl__cut_ears(core);
            core->effort += core->new_simplices * core->link_vertices;
        }
        if (status != PBW_OK) {
            (void)pbw__leave_cavity(&core->kernel, core->kernel.scratch.cavity_count);
        }
    }
#else
    (void)core;
    (void)v;
#endif
    return status;
}

/* Removes a vertex.  PBWL__REBUILD: no simplex would be left, or its link is too large.  PBW__DEFERRED, from a task
   only: it does not own all vertices around, or would make no finite simplex, which may mean that none would be
   left. */
static pbw_status pbwl__remove_vertex(pbwl__core *core, pbw_index v)
{
    pbw__kernel *kernel = &core->kernel;
    size_t made, i;
    pbw_status status = pbwl__ear_hole(core, v);
    if (status == PBWL__UNSUITED) {
        status = pbwl__list_hole(core, v);
        if (status != PBW_OK) {
            return status;
        }
        status = pbwl__gift_wrap(core);
    }
    for (made = i = 0; i < core->new_simplices; i++) {
        made += core->new_simplex[i].v[kernel->dim] != 0;
    }
    if (status == PBW_OK && made == 0) {
        status = kernel->own.owner != NULL ? PBW__DEFERRED
               : core->simplex_count == pbwl__count_finite(kernel) ? PBWL__REBUILD : PBW_OK;
    }
    if (status != PBW_OK) {
        (void)pbw__leave_cavity(kernel, kernel->scratch.cavity_count);
        return status;
    }
    kernel->scratch.facet_count = core->new_simplices;
    status = pbw__take_slots(kernel);
    if (status != PBW_OK) {
        return pbwl__no_room(kernel, status);
    }
    pbwl__fill_hole(core);
    core->incident[v] = PBWL__VERTEX_REMOVED;
    pbwl__note_star(core);
    return PBW_OK;
}

/* ---- insertion, and hidden vertices */
/* Lists a vertex as hidden after the commit, in simplex `container`; PBW_NONE: not known yet. */
static int pbwl__hide_vertex(pbwl__core *core, pbw_index v, pbw_index container)
{
    if (!PBWL__CORE_GROW(core, next_hidden, core->next_hidden_count + 1)
        || !PBWL__CORE_GROW(core, next_container, core->next_hidden_count + 1)) {
        return 0;
    }
    core->next_hidden[core->next_hidden_count] = v;
    core->next_container[core->next_hidden_count++] = container;
    core->incident[v] = PBW_NONE;
    return 1;
}

/* Walks by exact signs from *start to a simplex that contains a vertex that is no corner, or to a ghost.
   PBW__DEFERRED: not all vertices on the way are ours. */
static pbw_status pbwl__locate_vertex(pbwl__core *core, pbw_index *start, pbw_index vertex)
{
    pbw__kernel *kernel = &core->kernel;
    const int dim = kernel->dim;
    const double *p = pbwl__core_record(core, vertex);
    pbw_index t = pbw__walk_start(kernel, *start, dim);
    unsigned k = 0;
    while (k <= (unsigned)dim && kernel->corner[4 * (size_t)t + (size_t)dim] != PBW__GHOST) {
        if (!pbwl__hold_corners(kernel, t)) {
            return PBW__DEFERRED;
        }
        k = pbw__exit(kernel, t, p, 0);
        t = k <= (unsigned)dim ? (pbw_index)(kernel->link[4 * (size_t)t + k] >> 2) : t;
    }
    *start = t;
    return PBW_OK;
}

/* Inserts a vertex; the walk starts from simplex `hint`.  The vertex may be hidden, or hide others. */
static pbw_status pbwl__insert_vertex(pbwl__core *core, pbw_index v, pbw_index hint)
{
    pbw__kernel *kernel = &core->kernel;
    size_t i;
    pbw_status status;
    kernel->last = hint;
    kernel->scratch.facet_count = 0;
    core->inserting = kernel->weighted;
    status = kernel->insert(kernel, v);
    core->inserting = 0;
    if (status != PBW_OK) {
        return pbwl__no_room(kernel, status);
    }
    if (kernel->scratch.facet_count == 0) {
        kernel->last = hint;
        status = pbwl__locate_vertex(core, &hint, v);
        return status != PBW_OK || pbwl__hide_vertex(core, v, hint) ? status : PBW_ERROR_MEMORY;
    }
    pbwl__note_star(core);
    for (i = 0; i < core->link_vertices && kernel->weighted; i++) {
        if (core->incident[core->link_vertex[i]] == PBW_NONE
            && !pbwl__hide_vertex(core, core->link_vertex[i], PBW_NONE)) {
            return PBW_ERROR_MEMORY;
        }
    }
    return PBW_OK;
}

/* Returns a simplex to start a walk from: that in slot t, if there is one, or one of the last star. */
static pbw_index pbwl__start_near(const pbwl__core *core, pbw_index t)
{
    const pbw__kernel *kernel = &core->kernel;
    if (t >= PBWL__VERTEX_REMOVED || kernel->corner[4 * (size_t)t] == PBW_NONE) {
        for (t = kernel->last != PBW_NONE ? kernel->last : 0; kernel->corner[4 * (size_t)t] == PBW_NONE; t++) {
        }
    }
    return t;
}

/* Inserts hidden vertices without a container, or with one that was deleted, until each hidden one has one. */
static pbw_status pbwl__settle_hidden(pbwl__core *core)
{
    int again = 1;
    while (again) {
        size_t i, kept = 0;
        const size_t count = core->next_hidden_count;
        again = 0;
        for (i = 0; i < count; i++) {
            const pbw_index v = core->next_hidden[i], container = core->next_container[i];
            pbw_status status;
            if (container != PBW_NONE && !core->touched[container]) {
                continue;
            }
            core->next_hidden[i] = PBW__GHOST;
            status = pbwl__insert_vertex(core, v, pbwl__start_near(core, container));
            if (status != PBW_OK) {
                return status;
            }
            again |= core->incident[v] < PBWL__VERTEX_REMOVED;
        }
        for (i = 0; i < core->next_hidden_count; i++) {
            if (core->next_hidden[i] != PBW__GHOST) {
                core->next_hidden[kept] = core->next_hidden[i];
                core->next_container[kept++] = core->next_container[i];
            }
        }
        core->next_hidden_count = kept;
    }
    return PBW_OK;
}

static void pbwl__swap_lists(pbw_index **a, size_t *a_capacity, pbw_index **b, size_t *b_capacity)
{
    pbw_index *list = *a;
    const size_t capacity = *a_capacity;
    *a = *b;
    *a_capacity = *b_capacity;
    *b = list;
    *b_capacity = capacity;
}

/* Makes the next hidden vertices the hidden ones. */
static void pbwl__swap_hidden(pbwl__core *core)
{
    pbwl__swap_lists(&core->hidden, &core->hidden_capacity, &core->next_hidden, &core->next_hidden_capacity);
    pbwl__swap_lists(&core->container, &core->container_capacity, &core->next_container,
                     &core->next_container_capacity);
    core->hidden_count = core->next_hidden_count;
    core->next_hidden_count = 0;
}

/* ------------------------------------------------------------------------------------------------------
   >>creation     From points to a core.
   In: points and their numbers.  Out: a core that triangulates them, in space with its slots along the curve.
   Holds: the invariants of >>core; the journal is empty.
   ------------------------------------------------------------------------------------------------------ */
/* The points with the numbers in `list`, contiguous and in that order.  list NULL: the points of all numbers, in the
   arrays of the live triangulation, which owns them; room is 0 then. */
typedef struct pbwl__gathered {
    double *points, *weights;
    pbw_index *list;
    size_t count, room, dim;
} pbwl__gathered;

static void pbwl__gathered_free(pbw_memory *memory, pbwl__gathered *gathered)
{
    if (gathered->room > 0) {
        pbw__release(memory, gathered->points, gathered->room * gathered->dim, sizeof(double));
        pbw__release(memory, gathered->weights, gathered->room, sizeof(double));
        pbw__release(memory, gathered->list, gathered->room, sizeof(pbw_index));
    }
    memset(gathered, 0, sizeof(*gathered));
}

static int pbwl__gathered_create(pbw__context *context, pbwl__gathered *gathered, size_t room, int dim)
{
    pbw__block block[3];
    gathered->room = room;
    gathered->count = 0;
    gathered->dim = (size_t)dim;
    gathered->points = (double *)pbw__allocate(&context->memory, room * gathered->dim, sizeof(double));
    gathered->weights = (double *)pbw__allocate(&context->memory, room, sizeof(double));
    gathered->list = (pbw_index *)pbw__allocate(&context->memory, room, sizeof(pbw_index));
    block[0] = pbw__block_of(gathered->points, 0, room * gathered->dim * sizeof(double));
    block[1] = pbw__block_of(gathered->weights, 0, room * sizeof(double));
    block[2] = pbw__block_of(gathered->list, 0, room * sizeof(pbw_index));
    pbw__populate(context, block, 3);
    return gathered->points != NULL && gathered->weights != NULL && gathered->list != NULL;
}

/* Sets the point at index `at`. */
PBW__INLINE void pbwl__gathered_set(const pbwl__gathered *gathered, size_t at, pbw_index id, const double *x,
                                    double weight)
{
    double *to = gathered->points + at * gathered->dim;
    to[0] = x[0];
    to[1] = x[1];
    to[gathered->dim - 1] = x[gathered->dim - 1];
    gathered->weights[at] = weight;
    gathered->list[at] = id;
}

static void pbwl__gathered_input(const pbwl__gathered *gathered, int weighted, pbw__input *input)
{
    pbw_options none;
    memset(&none, 0, sizeof(none));
    *input = pbw__input_of((int)gathered->dim, 0, gathered->points, weighted ? gathered->weights : NULL,
                           gathered->count);
    (void)pbw__input_check(input, &none);
}

/* After the build: finds incident simplices, free slots and hidden vertices. */
static pbw_status pbwl__core_scan(pbwl__core *core)
{
    pbw__kernel *kernel = &core->kernel;
    pbw_index v, container;
    pbw__set_bytes(kernel->context, core->incident, 0xff,            /* PBW_NONE */
                   core->incident_capacity * sizeof(pbw_index));
    pbwl__scan_slots(core, 1);
    if (!pbwl__journal_reserve(core)) {
        return PBW_ERROR_MEMORY;
    }
    for (v = 1, container = kernel->last; v <= core->vertex_count && kernel->weighted; v++) {
        if (core->incident[v] == PBW_NONE) {
            (void)pbwl__locate_vertex(core, &container, (pbw_index)v);
            if (!pbwl__hide_vertex(core, v, container)) {
                return PBW_ERROR_MEMORY;
            }
        }
    }
    return PBW_OK;
}

/* list: per id of a vertex, its number.  box: per task, the box of its records. */
typedef struct pbwl__taking {
    pbwl__core *core;
    const pbw_index *list;
    double (*box)[8];
    int tasks;
} pbwl__taking;

/* Computes the box of a task's records, and names its vertices. */
PBW__INLINE void pbwl__core_take_of(const pbwl__taking *taking, int task, int dim)
{
    pbwl__core *core = taking->core;
    const size_t width = (size_t)dim + 1, end = pbw__share(core->vertex_count, task + 1, taking->tasks) + 1;
    double low[4] = { HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL };
    double high[4] = { -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL };
    size_t soon, r, k;
    pbw_index id;
    for (r = pbw__share(core->vertex_count, task, taking->tasks) + 1; r < end; r++) {
        const double *x = core->record + r * width;
        for (k = 0; k < width; k++) {
            low[k] = x[k] < low[k] ? x[k] : low[k];
            high[k] = x[k] > high[k] ? x[k] : high[k];
        }
        soon = core->name[r + 16 < end ? r + 16 : r];
        id = taking->list != NULL ? taking->list[core->name[r]] : core->name[r];
        PBW__PREFETCH_TO_WRITE(core->vertex + soon);
        PBW__PREFETCH_TO_WRITE(core->twin + soon);
        core->name[r] = id;
        core->vertex[id] = (pbw_index)r;
        core->twin[id] = id;
    }
    memcpy(taking->box[task], low, sizeof(low));
    memcpy(taking->box[task] + 4, high, sizeof(high));
}

static void pbwl__core_take_share(void *arg, int task)
{
    const pbwl__taking *taking = (const pbwl__taking *)arg;
    PBW__BY_DIM(taking->core->kernel.dim, pbwl__core_take_of, taking, task);
}

/* Makes room for vertices and numbers in a new core. */
static int pbwl__core_reserve(pbwl__core *core, size_t records, size_t numbers)
{
    pbw__context *context = core->kernel.context;
    pbw__block block[4];
    core->incident_capacity = core->link_index_capacity = records;
    core->vertex_capacity = core->twin_capacity = numbers;
    core->incident = (pbw_index *)pbw__allocate(&context->memory, records, sizeof(pbw_index));
    core->link_index = (pbw_index *)pbw__allocate(&context->memory, records, sizeof(pbw_index));
    core->vertex = (pbw_index *)pbw__allocate(&context->memory, numbers, sizeof(pbw_index));
    core->twin = (pbw_index *)pbw__allocate(&context->memory, numbers, sizeof(pbw_index));
    block[0] = pbw__block_of(core->incident, 0, records * sizeof(pbw_index));
    block[1] = pbw__block_of(core->link_index, 0, records * sizeof(pbw_index));
    block[2] = pbw__block_of(core->vertex, 0, numbers * sizeof(pbw_index));
    block[3] = pbw__block_of(core->twin, 0, numbers * sizeof(pbw_index));
    pbw__populate(context, block, 4);
    if (core->incident == NULL || core->link_index == NULL || core->vertex == NULL || core->twin == NULL) {
        return 0;
    }
    pbw__set_bytes(context, core->link_index, 0, records * sizeof(pbw_index));
    return 1;
}

/* Moves the records into the core, names the vertices, and chains the numbers at one point.  `canonical` and `id` of
   the vertices are indices in the list of numbers. */
static pbw_status pbwl__core_take(pbwl__core *core, pbw__vertices *vertices, const pbw_index *list)
{
    pbw__context *context = core->kernel.context;
    const size_t records = vertices->point_count + 1, width = (size_t)vertices->dim + 1;
    pbwl__taking taking;
    size_t i, k;
    core->record = vertices->record;
    core->record_capacity = records * width;
    core->name = vertices->id;
    core->name_capacity = records;
    core->vertex_count = vertices->count;
    core->duplicate_count = vertices->duplicate_count;
    core->grid = vertices->grid;
    vertices->record = NULL;
    vertices->room = 0;
    vertices->id = NULL;
    taking.core = core;
    taking.list = list;
    taking.tasks = pbw__tasks(context, vertices->count, 16384);
    taking.box = (double (*)[8])pbw__allocate(&context->memory, (size_t)taking.tasks, sizeof(*taking.box));
    if (taking.box == NULL) {
        return PBW_ERROR_MEMORY;
    }
    pbw__for(context, taking.tasks, pbwl__core_take_share, &taking);
    for (k = 0; k < width; k++) {
        core->low[k] = taking.box[0][k];
        core->high[k] = taking.box[0][4 + k];
        for (i = 1; i < (size_t)taking.tasks; i++) {
            core->low[k] = taking.box[i][k] < core->low[k] ? taking.box[i][k] : core->low[k];
            core->high[k] = taking.box[i][4 + k] > core->high[k] ? taking.box[i][4 + k] : core->high[k];
        }
    }
    pbw__release(&context->memory, taking.box, (size_t)taking.tasks, sizeof(*taking.box));
    for (i = 0; i < vertices->point_count && vertices->duplicate_count > 0; i++) {
        const pbw_index other = vertices->canonical[i];
        if (other != i && other != PBW_NONE) {
            const pbw_index id = list != NULL ? list[i] : (pbw_index)i, first = list != NULL ? list[other] : other;
            core->vertex[id] = core->vertex[first];
            core->twin[id] = core->twin[first];
            core->twin[first] = id;
        }
    }
    return PBW_OK;
}

/* Packs the slots of a build in space along the curve.  As built, half of the simplices are more than 1024 slots away
   from a neighbour; packed, one in 13 is, and tests of all vertices and removals take two thirds of the time. */
static pbw_status pbwl__core_pack(pbw__context *context, pbwl__core *core, pbw__vertices *vertices)
{
    pbw_memory *memory = &context->memory;
    pbw__store *store = &core->store;
    pbw__emission emission;
    pbw_status status;
    pbw__emission_start(&emission, context, store, vertices);
    emission.any_order = emission.packed = 1;
    emission.apart = emission.links_apart = 0;
    status = pbw__emit_all(&emission, store, vertices);
    store->count = store->region_slots = emission.simplex_count;
    pbw__release(memory, vertices->record, vertices->room, sizeof(double));
    vertices->record = NULL;
    if (!PBW__RESIZE(memory, store, mark, store->capacity)) {
        return PBW_ERROR_MEMORY;
    }
    pbw__set_bytes(context, store->mark, 0, store->capacity);
    return status;
}

/* Makes a kernel for the vertices of the core. */
static pbw_status pbwl__core_start(pbw__context *context, pbwl__core *core, pbw__vertices *vertices)
{
    pbw_status status;
    vertices->record = core->record;
    vertices->width = (size_t)vertices->dim + 1;
    status = pbw__kernel_create(&core->kernel, context, &core->store, vertices, &core->grid);
    vertices->record = NULL;
    core->kernel.journal = core;
    core->kernel.note_cavity = pbwl__journal_cavity;
    core->kernel.note_slots = pbwl__journal_slots;
    core->kernel.slots.region = 0;                   /* all free slots are in the list */
    core->kernel.slots.free_list = PBW_NONE;
    core->store.region_bits = 31;
    return status;
}

/* Triangulates points, and frees them; PBW_DEGENERATE: there are no simplices.  The caller frees the core and, if
   they are still there, the points. */
static pbw_status pbwl__core_build(pbw__context *context, pbwl__gathered *gathered, int weighted, size_t numbers,
                                   pbwl__core *core)
{
    pbw__vertices vertices;
    pbw__input input;
    pbw_statistics statistics;
    pbw_status status;
    memset(core, 0, sizeof(*core));
    memset(&statistics, 0, sizeof(statistics));
    core->kernel.context = context;
    core->kernel.dim = (int)gathered->dim;
    if (gathered->count == 0) {
        return PBW_DEGENERATE;
    }
    pbwl__gathered_input(gathered, weighted, &input);
    input.padded = 1;
    status = pbw__enter_stage(context, PBW_STAGE_ORDER) ? PBW_CANCELLED : pbw__order(context, &input, &vertices);
    if (status != PBW_OK) {
        return status;
    }
    status = pbw__enter_stage(context, PBW_STAGE_BUILD) ? PBW_CANCELLED
           : pbw__build_all(context, &core->store, &vertices, &vertices.grid, &statistics);
    if (status == PBW_OK || status == PBW_DEGENERATE) {
        pbw_status taken = vertices.duplicate_count == 0 ? PBW_OK : pbw__make_canonical(context, &vertices, NULL);
        taken = taken != PBW_OK ? taken
              : !pbwl__core_reserve(core, vertices.point_count + 1, numbers) ? PBW_ERROR_MEMORY
              : pbwl__core_take(core, &vertices, gathered->list);
        status = taken != PBW_OK ? taken : status;
        pbwl__gathered_free(&context->memory, gathered);
    }
    if (status == PBW_OK && core->kernel.dim == 3 && sizeof(pbw__link) == sizeof(pbw_index)) {
        status = pbwl__core_pack(context, core, &vertices);
    }
    status = status == PBW_OK ? pbwl__core_start(context, core, &vertices) : status;
    core->sorted = 1;
    if (status == PBW_OK) {
        status = pbwl__core_scan(core);
        pbwl__swap_hidden(core);
        pbwl__journal_clear(core);
    } else if (status == PBW_DEGENERATE) {
        pbw__store_free(&context->memory, &core->store);
    }
    pbw__vertices_free(context, &vertices);
    return status;
}
/* ------------------------------------------------------------------------------------------------------
   >>verify       After vertices moved: tests whether the triangulation still holds; flips edges until it does.
   In: a triangulation, other coordinates of its vertices.  Out: whether it is their triangulation too; in the plane,
   after flips.
   Holds: a core is the triangulation of its vertices if (1) its finite simplices are positive, (2) all facets are
   locally regular and the hull is locally convex, and (3) some point o inside one simplex is in no other and is on
   the inner side of each facet of the hull.  For a straight walk from any point in any simplex to o cannot leave
   through the hull; it ends in the simplex of o, and backwards it leads to one simplex only.  So no point is covered
   twice. (Without o a star might wind twice round a vertex, all its simplices positive.)

   A ray from o to infinity tells in how many simplices o is.  No simplex covers its far end.  A point that moves
   along it leaves one simplex more than it enters where the ray crosses a facet of the hull, and, as o is inside of
   all of them, it only ever leaves there.  So o is in one simplex if the ray meets one facet of the hull.  (A ray
   through a face of the hull meets two facets, which counts as a fault.)

   Flips (Lawson 1977) replace an edge that is not locally Delaunay by the other diagonal of its two triangles.  If
   their quadrilateral is not strictly convex, or flips are too many, the caller takes another way.  An edge at the
   ghost is flipped if the hull is not convex there.
   ------------------------------------------------------------------------------------------------------ */
#define PBWL__INVERTED 128                           /* a mark: the simplex is not positive; else bits of facets */

typedef struct pbwl__verifying {
    pbwl__core *core;
    double o[4], ahead[4];                           /* a point inside of a simplex; another one on a ray from it */
    size_t inverted, failing, most, covers;          /* most: with more failing facets the test is given up */
    float *depth;                                    /* four for each of the slots from..to-1; NULL: no vectors */
    size_t from, to;
    double scale;                                    /* of the depths */
} pbwl__verifying;

/* Returns the orientation of a simplex with corner i (dim+1: none) replaced by p, which need not be on the grid. */
static int pbwl__slot_side(const pbwl__core *core, size_t t, int i, const double *p)
{
    const int dim = core->kernel.dim;
    const double *x[4] = { NULL, NULL, NULL, NULL };
    int k;
    for (k = 0; k <= dim; k++) {
        x[k] = k == i ? p : pbwl__core_record(core, core->kernel.corner[4 * t + (size_t)k]);
    }
    return pbw__orient(dim, x, i > dim ? &core->grid : NULL);
}

/* Returns the set of facets of the simplex in slot t that are not locally regular, or PBWL__INVERTED.  all: tests
   each facet, not only those that are tested from this side. */
PBW__INLINE unsigned pbwl__slot_faults(const pbwl__core *core, size_t t, int all, int dim)
{
    const pbw_index *v = core->kernel.corner + 4 * t;
    const pbw__link *link = core->kernel.link + 4 * t;
    const int ghost = v[dim] == PBW__GHOST;
    pbwl__plane plane;
    unsigned faults = 0;
    int k;
    memset(&plane, 0, sizeof(plane));
    if (!ghost) {
        double side;
        pbwl__plane_of(core, v, dim, &plane);
        side = plane.orientation;
        if (!(side > 0.0 && side * side > pbwl__side_limit(plane.height, dim))
            && pbwl__slot_side(core, t, dim + 1, NULL) <= 0) {
            return PBWL__INVERTED;
        }
    }
    for (k = 0; k <= dim - ghost; k++) {
        const pbw_index far = core->kernel.corner[link[k]];
        const double *e = core->record + far * ((size_t)dim + 1);
        double row[5];
        if (far == PBW__GHOST || (!ghost && !all && t > link[k] >> 2)) {
            continue;
        }
        row[4] = ghost ? 0.0 : pbwl__plane_row(&plane, e, dim, row);
        if (ghost ? pbw__simplex_conflict(&core->kernel, (pbw_index)t, e)
                  : pbwl__plane_conflict(core, &plane, v, far, row, dim)) {
            faults |= 1u << k;
        }
    }
    return faults;
}

/* ---- depths
   The depth of facet k of a simplex is the signed way from it to the centre of the simplex's sphere, inwards, times
   twice the facet's measure.  A facet is locally regular if its depths on both sides add up to more than 0: in the
   plane, if cot(d) + cot(e) > 0 for the angles d and e opposite to an edge (Cline and Renka 1984).  So each simplex
   of a window of slots is read once, and again if it is behind a facet of an earlier window.

   Proof.  Let f be linear on each simplex, with the lifts of vertices as its values.  A facet is locally regular if f
   is convex across it, that is, if its slope along the facet's normal n grows.  With the last corner d as the origin,
   the rows a, b, c of the other corners and the minors m of >>predicates, V = a.m_a is the orientation, N = l_a m_a +
   l_b m_b + l_c m_c, and the slope of f is N / V + 2 d.  m_i is the inner normal across from corner i, of length
   twice the facet's area (in the plane: its length), so that across from d is -sum m.  From a corner q of the facet
   the slope along the inner normal is H / V, H = N.n + 2 V (d - q).n: H_i = N.m_i, and, with q = a, H_d = 2 V^2 - sum
   H_i, as a.m_a = V and a.m_b = a.m_c = 0.  Both sides have one facet and opposite normals: the sum of the two H / V
   is minus what the slope grows by, from outside to inside, so it must be positive.

   A depth is stored as a lower bound in single precision, so the sum of two is certain if it is positive.  Roundings
   and absolute products, see >>predicates, u = 2^-53, with the largest height h:
                in the plane                                      in space
      V         2 differences, product, sum: 4, h                 3, minor 2, product, 2 sums: 8, 6 h^(3/2)
      H_i       lift 5, |b|^2 4, product, sum: 11, 2 h^2          lift 6, minors 4 each, products, sums: 20, 36 h^3
      H_d       sum, difference: 13, 6 h^2: 78 u h^2              2 sums, difference: 23, 180 h^3: 4140 u h^3
   Absolute products in the plane are at most |a| |b| (Cauchy).  Where V is above 1e-6 h, or 5e-6 h^(3/2), and so has
   a relative error of 8 u / 5e-6 * 6 = 1.1e-9, a depth is (H - bound) (scale / V): that error, three roundings, and a
   conversion of 2^-24 change it by less than 1e-7 of it.  Underflow takes less than half of the least float, 2^-150,
   and, if scale / V is denormal, 2^-1075 (36 h^3), h^3 < 1e270.  Depths are in units of the scale, which is that of
   the points' box.  Other simplices, ghosts and free slots get NaN: their signs stay undecided. */
#define PBWL__DEPTH2_ERROR 9e-15                     /* of H, times h^2, h^3 */
#define PBWL__DEPTH3_ERROR 4.7e-13
#define PBWL__DEPTH2_LEAST 1e-12                     /* of V^2, times h^2, h^3 */
#define PBWL__DEPTH3_LEAST 2.5e-11
#define PBWL__DEPTH_V_ERROR 1.2e-9                   /* of V, relative */
#define PBWL__DEPTH_ERROR 1e-7                       /* of a depth, relative */
#define PBWL__DEPTH_LOST 1e-45                       /* to underflow */
#define PBWL__DEPTH_MOST 1e270                       /* of h^2, h^3 */

#ifdef PBW__SIMD
/* Makes the points of four vertices the origins of the four lanes. */
PBW__SIMD_INLINE void pbwl__origins4(const double *record, const pbw_index *v, pbw__point4 *origin)
{
    const size_t width = (size_t)origin->dim + 1;
    const double *a = record + width * v[0], *b = record + width * v[1], *c = record + width * v[2],
                 *d = record + width * v[3];
    pbw__columns(a, b, c, d, &origin->x, &origin->y);
    if (origin->dim == 3) {
        pbw__columns(a + 2, b + 2, c + 2, d + 2, &origin->z, &origin->weight);
    } else if (origin->weighted) {
        origin->weight = pbw__four(a[2], b[2], c[2], d[2]);
    }
}

/* Computes V and H of four simplices, one in each lane, with the last corners as origins.  Returns the largest
   heights. */
PBW__SIMD_INLINE pbw__d4 pbwl__depths4(const double *record, pbw_index v[4][4], const pbw__point4 *origin, pbw__d4 *V,
                                       pbw__d4 *H)
{
    const pbw__rows4 a = pbw__rows4_of(record, v[0], 0, origin), b = pbw__rows4_of(record, v[1], 0, origin);
    const pbw__d4 h = pbw__max4(pbw__max4(a.height, b.height), pbw__splat(1e-55));
    if (origin->dim == 2) {
        const pbw__d4 aa = pbw__fma(a.y, a.y, a.x * a.x), bb = pbw__fma(b.y, b.y, b.x * b.x);
        const pbw__d4 ab = pbw__fma(a.y, b.y, a.x * b.x), side = pbw__det2(a.x, a.y, b.x, b.y);
        H[0] = pbw__det2(a.lift, b.lift, ab, bb);
        H[1] = pbw__det2(b.lift, a.lift, ab, aa);
        H[2] = (side + side) * side - (H[0] + H[1]);
        H[3] = H[2];
        *V = side;
        return h;
    } else {
        const pbw__rows4 c = pbw__rows4_of(record, v[2], 0, origin);
        const pbw__d4 ax = pbw__det2(c.y, c.z, b.y, b.z), bx = pbw__det2(a.y, a.z, c.y, c.z),
                      cx = pbw__det2(b.y, b.z, a.y, a.z), ay = pbw__det2(c.z, c.x, b.z, b.x),
                      by = pbw__det2(a.z, a.x, c.z, c.x), cy = pbw__det2(b.z, b.x, a.z, a.x),
                      az = pbw__det2(c.x, c.y, b.x, b.y), bz = pbw__det2(a.x, a.y, c.x, c.y),
                      cz = pbw__det2(b.x, b.y, a.x, a.y);
        const pbw__d4 nx = pbw__dot4(a.lift, b.lift, c.lift, ax, bx, cx);
        const pbw__d4 ny = pbw__dot4(a.lift, b.lift, c.lift, ay, by, cy);
        const pbw__d4 nz = pbw__dot4(a.lift, b.lift, c.lift, az, bz, cz);
        const pbw__d4 side = pbw__dot4(a.x, a.y, a.z, ax, ay, az);
        H[0] = pbw__dot4(nx, ny, nz, ax, ay, az);
        H[1] = pbw__dot4(nx, ny, nz, bx, by, bz);
        H[2] = pbw__dot4(nx, ny, nz, cx, cy, cz);
        H[3] = (side + side) * side - (H[0] + H[1] + H[2]);
        *V = side;
        return pbw__max4(h, c.height);
    }
}

/* Row i of the four rows in `to` gets lane i of a, b, c and d, rounded to single precision. */
PBW__SIMD_INLINE void pbwl__store_rows(float *to, pbw__d4 a, pbw__d4 b, pbw__d4 c, pbw__d4 d)
{
#ifdef PBW__AVX2
    __m128 row[4];
    int i;
    row[0] = _mm256_cvtpd_ps(a);
    row[1] = _mm256_cvtpd_ps(b);
    row[2] = _mm256_cvtpd_ps(c);
    row[3] = _mm256_cvtpd_ps(d);
    _MM_TRANSPOSE4_PS(row[0], row[1], row[2], row[3]);
    for (i = 0; i < 4; i++) {
        _mm_storeu_ps(to + 4 * i, row[i]);
    }
#else
    float32x4x4_t columns;
    columns.val[0] = vcvt_high_f32_f64(vcvt_f32_f64(pbw__half(a, 0)), pbw__half(a, 1));
    columns.val[1] = vcvt_high_f32_f64(vcvt_f32_f64(pbw__half(b, 0)), pbw__half(b, 1));
    columns.val[2] = vcvt_high_f32_f64(vcvt_f32_f64(pbw__half(c, 0)), pbw__half(c, 1));
    columns.val[3] = vcvt_high_f32_f64(vcvt_f32_f64(pbw__half(d, 0)), pbw__half(d, 1));
    vst4q_f32(to, columns);
#endif
}

/* Stores the depths of the simplices in four slots: NaN unless the simplex is certainly positive.  Free slots read
   the record of the ghost, too. */
PBW__SIMD_INLINE void pbwl__depths_of(const pbwl__verifying *verifying, const pbw_index *slot, float *depths, int dim)
{
    const pbwl__core *core = verifying->core;
    const pbw__d4 nan = pbw__splat(HUGE_VAL) - pbw__splat(HUGE_VAL);
    pbw__point4 origin = pbw__point4_of(core->record, dim, core->kernel.weighted, (size_t)dim + 1);
    pbw__d4 h, V, H[4], power, scale, certain;
    pbw_index v[4][4];
    unsigned i, k;
    for (i = 0; i < 4; i++) {
        const pbw_index *corner = core->kernel.corner + 4 * (size_t)slot[i];
        const pbw_index used = 0 - (pbw_index)(corner[0] != PBW_NONE);
        for (k = 0; k <= (unsigned)dim; k++) {
            v[k][i] = corner[k] & used;
        }
    }
    pbwl__origins4(core->record, v[dim], &origin);
    h = pbwl__depths4(core->record, v, &origin, &V, H);
    power = dim == 2 ? h * h : h * h * h;
    certain = pbw__greater(V * V, power * pbw__splat(dim == 2 ? PBWL__DEPTH2_LEAST : PBWL__DEPTH3_LEAST));
    certain = pbw__and4(certain, pbw__greater(pbw__splat(PBWL__DEPTH_MOST), power));
    certain = pbw__and4(certain, pbw__greater(V, pbw__splat(0.0)));
    scale = pbw__blend(nan, pbw__splat(verifying->scale) / V, certain);
    power = power * pbw__splat(dim == 2 ? PBWL__DEPTH2_ERROR : PBWL__DEPTH3_ERROR);
    for (k = 0; k < 4; k++) {
        const pbw__d4 depth = (H[k] - power) * scale;
        H[k] = depth - pbw__fma(pbw__abs4(depth), pbw__splat(PBWL__DEPTH_ERROR), pbw__splat(PBWL__DEPTH_LOST));
    }
    pbwl__store_rows(depths, H[0], H[1], H[2], H[3]);
}

/* pbwl__depths_of for a list of slots; count is a multiple of four. */
PBW__SIMD static PBW__NOINLINE void pbwl__depths(const pbwl__verifying *verifying, const pbw_index *slot,
                                                 size_t count, float *depths)
{
    const int dim = verifying->core->kernel.dim;
    size_t i;
    for (i = 0; i < count; i += 4) {
        PBW__BY_DIM(dim, pbwl__depths_of, verifying, slot + i, depths + 4 * i);
    }
}
#endif

#define PBWL__VERIFIED ((size_t)65536)               /* slots of a window, for each thread: a megabyte of depths */
#define PBWL__PENDING ((size_t)64)                   /* facets between windows that are judged together */

/* Returns whether the ray from o through `ahead` meets the closed facet of the ghost in slot t: ahead - o is then a
   sum of (corner - o) without negative coefficients. */
static int pbwl__ray_meets(const pbwl__verifying *verifying, size_t t)
{
    const pbwl__core *core = verifying->core;
    const int dim = core->kernel.dim;
    const double *x[4] = { NULL, NULL, NULL, NULL };
    int i, side = -1;
    for (i = 0; i < dim; i++) {
        x[i] = pbwl__core_record(core, core->kernel.corner[4 * t + (size_t)i]);
    }
    x[dim] = verifying->o;
    for (i = 0; i < dim && side <= 0; i++) {         /* negative with all corners: o is inside */
        side = pbw__side(dim, x, i, verifying->ahead, NULL);
    }
    return side <= 0;
}

/* Returns 2 if o is not on the inner side of the facet of the ghost in slot t, 1 if the ray meets this facet. */
static size_t pbwl__covers(const pbwl__verifying *verifying, size_t t)
{
    return pbwl__slot_side(verifying->core, t, verifying->core->kernel.dim, verifying->o) >= 0
           ? 2 : (size_t)pbwl__ray_meets(verifying, t);
}

/* Judges exactly those facets of a simplex that are tested from this side. */
static PBW__NOINLINE void pbwl__verify_slot(pbwl__verifying *verifying, size_t t)
{
    pbwl__core *core = verifying->core;
    const unsigned faults = core->kernel.dim == 3 ? pbwl__slot_faults(core, t, 0, 3)
                                                  : pbwl__slot_faults(core, t, 0, 2);
    if (faults != 0 && core->kernel.mark[t] == 0) {  /* it may be judged for each facet */
        core->kernel.mark[t] = (unsigned char)faults;
        (void)PBW__ADD(faults == PBWL__INVERTED ? &verifying->inverted : &verifying->failing, 1);
    }
}

#ifdef PBW__SIMD
/* Computes the depths of slots from..to-1 of the window. */
static pbw_status pbwl__verify_depths(void *arg, size_t from, size_t to)
{
    const pbwl__verifying *verifying = (const pbwl__verifying *)arg;
    pbw_index slot[64];
    for (; from < to; from += 64) {
        const size_t count = to - from < 64 ? to - from : 64;
        size_t i;
        for (i = 0; i < 64; i++) {                   /* the last ones fill up to a multiple of four */
            slot[i] = (pbw_index)(verifying->from + from + (i < count ? i : count - 1));
        }
        pbwl__depths(verifying, slot, (count + 3) / 4 * 4, verifying->depth + 4 * from);
    }
    return PBW_OK;
}

/* Facets between this window and later ones. */
typedef struct pbwl__verify_links { size_t count; pbw__link pending[PBWL__PENDING + 4]; } pbwl__verify_links;

/* Judges the pending facets, and empties the list. */
static void pbwl__verify_pending(pbwl__verifying *verifying, pbwl__verify_links *links)
{
    const pbw__link *link = verifying->core->kernel.link;
    float behind[4 * (PBWL__PENDING + 4)];
    pbw_index slot[PBWL__PENDING + 4];
    size_t i;
    for (i = 0; i < (links->count + 3) / 4 * 4; i++) {
        slot[i] = (pbw_index)(link[links->pending[i < links->count ? i : 0]] >> 2);
    }
    pbwl__depths(verifying, slot, i, behind);
    for (i = 0; i < links->count; i++) {
        const pbw__link here = links->pending[i];
        if (!(verifying->depth[here - 4 * verifying->from] + behind[4 * i + (link[here] & 3)] > 0.0f)) {
            pbwl__verify_slot(verifying, here >> 2);
        }
    }
    links->count = 0;
}

/* Returns whether facet `here` is certainly locally regular, or is judged elsewhere.  Branchless: the slot across is
   unpredictable. */
PBW__INLINE int pbwl__verify_facet(const pbwl__verifying *verifying, pbwl__verify_links *links, pbw__link here)
{
    const pbw__link first = (pbw__link)(4 * verifying->from), all = (pbw__link)(4 * verifying->to) - first;
    const pbw__link across = verifying->core->kernel.link[here], there = across - first;
    links->pending[links->count] = here;
    links->count += across >= first + all;
    return verifying->depth[here - first] + verifying->depth[there < all ? there : all] > 0.0f;
}

/* Judges the facets of slots from..to-1 by their depths on both sides, or exactly.  For slots outside of the window
   the depth at its end, infinity, leaves the facet to another test. */
PBW__INLINE void pbwl__verify_facets_of(pbwl__verifying *shared, size_t from, size_t to, int dim)
{
    const pbwl__verifying verifying = *shared;       /* a copy, as the stores below might alias it */
    const pbw_index *corner = verifying.core->kernel.corner;
    pbwl__verify_links links;
    size_t covers = 0, t;
    links.count = 0;
    for (t = from; t < to; t++) {
        const pbw__link here = (pbw__link)(4 * t);
        int certain;
        if (corner[here] == PBW_NONE) {
            continue;
        }
        certain = pbwl__verify_facet(&verifying, &links, here) & pbwl__verify_facet(&verifying, &links, here + 1)
                & pbwl__verify_facet(&verifying, &links, here + 2)
                & (dim == 2 || pbwl__verify_facet(&verifying, &links, here + 3));
        if (PBW__UNLIKELY(!certain)) {
            pbwl__verify_slot(shared, t);
            covers += corner[here + (unsigned)dim] == PBW__GHOST ? pbwl__covers(shared, t) : 0;
        }
        if (links.count >= PBWL__PENDING) {
            pbwl__verify_pending(shared, &links);
        }
    }
    pbwl__verify_pending(shared, &links);
    (void)PBW__ADD(&shared->covers, covers);
}
#endif

/* Adds pbwl__covers of the ghosts in slots from..to-1. */
static pbw_status pbwl__cover_range(void *arg, size_t from, size_t to)
{
    pbwl__verifying *verifying = (pbwl__verifying *)arg;
    const pbw_index *corner = verifying->core->kernel.corner;
    const size_t dim = (size_t)verifying->core->kernel.dim;
    size_t covers = 0, t;
    for (t = from; t < to; t++) {
        covers += corner[4 * t] != PBW_NONE && corner[4 * t + dim] == PBW__GHOST ? pbwl__covers(verifying, t) : 0;
    }
    (void)PBW__ADD(&verifying->covers, covers);
    return PBW_OK;
}

/* Judges the simplices and facets of slots from..to-1 of the window, and counts as pbwl__cover_range does. */
static pbw_status pbwl__verify_range(void *arg, size_t from, size_t to)
{
    pbwl__verifying *verifying = (pbwl__verifying *)arg;
    const pbw_index *corner = verifying->core->kernel.corner;
    size_t t;
    from += verifying->from;
    to += verifying->from;
    if (PBW__LOAD(&verifying->inverted) > 0 || PBW__LOAD(&verifying->failing) > verifying->most) {
        return PBWL__REBUILD;
    }
#ifdef PBW__SIMD
    if (verifying->depth != NULL) {
        PBW__BY_DIM(verifying->core->kernel.dim, pbwl__verify_facets_of, verifying, from, to);
        return PBW_OK;
    }
#endif
    for (t = from; t < to; t++) {
        if (corner[4 * t] != PBW_NONE) {
            pbwl__verify_slot(verifying, t);
        }
    }
    return pbwl__cover_range(verifying, from, to);
}

/* Where no facet may fail, tests a sample first: if many facets fail, one of these does. */
static pbw_status pbwl__verify_some(const pbwl__core *core)
{
    const size_t count = core->store.count, step = count / 256 + 1;
    const int dim = core->kernel.dim;
    size_t t;
    for (t = 0; t < count && step >= 16; t += step) {
        if (core->kernel.corner[4 * t] != PBW_NONE && pbwl__slot_faults(core, t, 1, dim) != 0) {
            return PBWL__REBUILD;
        }
    }
    return PBW_OK;
}

#ifdef PBW__SIMD
/* Tests all simplices, window by window, with vectors. */
static pbw_status pbwl__verify_windows(pbwl__verifying *verifying)
{
    pbwl__core *core = verifying->core;
    pbw__context *context = core->kernel.context;
    const size_t count = core->store.count, least = PBW__SMALLER(PBWL__VERIFIED);
    const size_t most = least * (size_t)context->threads;
    const size_t room = 4 * ((count < most ? count : most) + 4);
    pbw_status status = PBW_OK;
    int k;
    verifying->scale = (double)core->vertex_count;
    for (k = 0; k < core->kernel.dim; k++) {
        verifying->scale /= core->high[k] - core->low[k];
    }
    verifying->scale = verifying->scale >= 1e-300 && verifying->scale <= 1e300 ? verifying->scale : 1.0;
    verifying->depth = (float *)pbw__allocate(&context->memory, room, sizeof(float));
    if (verifying->depth == NULL) {
        return PBW_ERROR_MEMORY;
    }
    for (verifying->from = 0; verifying->from < count && status == PBW_OK; verifying->from = verifying->to) {
        const size_t rest = count - verifying->from, before = verifying->from > least ? verifying->from : least;
        const size_t wanted = before < most ? before : most;         /* they double: most failures come early */
        const size_t length = rest < wanted ? rest : wanted;
        const double done = 0.5 * (double)verifying->from / (double)count;
        verifying->to = verifying->from + length;
        status = pbw__for_range(context, length, 4096, done, pbwl__verify_depths, verifying);
        verifying->depth[4 * length] = (float)HUGE_VAL;
        if (status == PBW_OK) {
            status = pbw__for_range(context, length, 4096, done, pbwl__verify_range, verifying);
        }
    }
    pbw__release(&context->memory, verifying->depth, room, sizeof(float));
    return status;
}
#endif

/* Tests all simplices. */
static pbw_status pbwl__verify_all(pbwl__verifying *verifying)
{
    pbwl__core *core = verifying->core;
    const pbw_status status = verifying->most == 0 ? pbwl__verify_some(core) : PBW_OK;
#ifdef PBW__SIMD
    if (status == PBW_OK && pbw__simd_works()) {
        return pbwl__verify_windows(verifying);
    }
#endif
    return status != PBW_OK ? status
         : pbw__for_range(core->kernel.context, core->store.count, 4096, 0.5, pbwl__verify_range, verifying);
}

/* Chooses o inside a simplex, of a few in the middle of the store, and a ray.  Returns 0 if rounding puts each
   outside of its simplex. */
static int pbwl__choose_inside(pbwl__verifying *verifying)
{
    static const double direction[3] = { 0.31, 0.19, -0.23 };
    const pbwl__core *core = verifying->core;
    const int dim = core->kernel.dim;
    const size_t count = core->store.count;
    size_t step, left = 64;
    int i, k, finite = 1;
    for (step = 0; step < count && left > 0; step++) {
        const size_t t = (count / 2 + step) % count;
        const pbw_index *v = core->kernel.corner + 4 * t;
        if (v[0] == PBW_NONE || v[dim] == PBW__GHOST) {
            continue;
        }
        left--;
        for (k = 0; k < dim; k++) {
            double low = HUGE_VAL, high = -HUGE_VAL;
            verifying->o[k] = 0.0;
            for (i = 0; i <= dim; i++) {
                const double x = pbwl__core_record(core, v[i])[k];
                verifying->o[k] += x / (double)(dim + 1);
                low = x < low ? x : low;
                high = x > high ? x : high;
            }
            verifying->ahead[k] = verifying->o[k] + direction[k] * (high - low);
            finite &= pbw__abs(verifying->ahead[k]) <= DBL_MAX;
        }
        verifying->o[dim] = verifying->ahead[dim] = 0.0;
        for (i = 0; i <= dim && pbwl__slot_side(core, t, i, verifying->o) > 0; i++) {
        }
        if (i > dim) {
            return finite;
        }
    }
    return 0;
}

/* ---- flips */
/* Returns how far to rotate the corners v to the left so that the ghost comes last. */
PBW__INLINE unsigned pbwl__ghost_turn(const pbw_index *v)
{
    return v[0] == PBW__GHOST ? 1 : v[1] == PBW__GHOST ? 2 : 0;
}

/* Sets corners and links of a triangle, and the links back. */
static void pbwl__set_triangle(pbw__kernel *kernel, size_t t, const pbw_index *v, const pbw__link *link)
{
    const unsigned turn = pbwl__ghost_turn(v);
    unsigned k;
    for (k = 0; k < 3; k++) {
        const pbw__link to = link[(k + turn) % 3];
        kernel->corner[4 * t + k] = v[(k + turn) % 3];
        kernel->link[4 * t + k] = to;
        kernel->link[to] = (pbw__link)(4 * t + k);
    }
}

/* Returns whether three vertices are a positive triangle, or one is the ghost. */
static int pbwl__may_be_triangle(const pbwl__core *core, const pbw_index *v)
{
    const double *x[3] = { pbwl__core_record(core, v[0]), pbwl__core_record(core, v[1]),
                           pbwl__core_record(core, v[2]) };
    return v[0] == PBW__GHOST || v[1] == PBW__GHOST || v[2] == PBW__GHOST || pbw__orient(2, x, &core->grid) > 0;
}

/* Replaces the edge opposite to corner k of t by the other diagonal.  PBWL__REBUILD: the quadrilateral is not
   convex. */
static pbw_status pbwl__flip(pbwl__core *core, size_t t, unsigned k)
{
    pbw__kernel *kernel = &core->kernel;
    const pbw__link across = kernel->link[4 * t + k], here = (pbw__link)(4 * t + k);
    const size_t u = (size_t)(across >> 2);
    const unsigned j = (unsigned)(across & 3), k1 = (k + 1) % 3, k2 = (k + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    const pbw_index p = kernel->corner[here], q = kernel->corner[across];
    const pbw_index a = kernel->corner[4 * t + k1], b = kernel->corner[4 * t + k2];
    const pbw_index first[3] = { p, a, q }, second[3] = { p, q, b };
    const unsigned at_a = (4 - pbwl__ghost_turn(first)) % 3, at_b = (5 - pbwl__ghost_turn(second)) % 3;
    const pbw__link of_first[3] = { kernel->link[4 * u + j1], (pbw__link)(4 * u + at_b), kernel->link[4 * t + k2] };
    const pbw__link of_second[3] = { kernel->link[4 * u + j2], kernel->link[4 * t + k1], (pbw__link)(4 * t + at_a) };
    pbw_status status;
    if (!pbwl__may_be_triangle(core, first) || !pbwl__may_be_triangle(core, second)) {
        return PBWL__REBUILD;
    }
    kernel->scratch.cavity[0] = (pbw_index)t;
    kernel->scratch.cavity[1] = (pbw_index)u;
    kernel->scratch.cavity_count = 2;
    status = pbwl__journal_cavity(kernel);
    if (status == PBW_OK) {
        pbwl__set_triangle(kernel, t, first, of_first);
        pbwl__set_triangle(kernel, u, second, of_second);
        pbwl__note_corners(core, t);
        pbwl__note_corners(core, u);
    }
    return status;
}

/* Flips until all edges are locally Delaunay; `edge` is the worklist, with `count` edges at first.  PBWL__REBUILD:
   more than `most` flips.  A task notes in `untested` the edges at which it does not own all vertices. */
static pbw_status pbwl__flip_all(pbwl__core *core, size_t count, size_t most)
{
    pbw__kernel *kernel = &core->kernel;
    size_t flips = 0;
    pbw_status status = PBW_OK;
    while (count > 0 && status == PBW_OK) {
        const pbw__link facet = core->edge[--count];
        const size_t s = (size_t)(kernel->link[facet] >> 2), t = (size_t)(facet >> 2);
        const int ghost = kernel->corner[4 * t + 2] == PBW__GHOST;
        const pbw_index far = kernel->corner[kernel->link[facet]];
        unsigned k = (unsigned)(facet & 3);
        if (far == PBW__GHOST || (ghost && k == 2)
            || !pbw__simplex_conflict(kernel, (pbw_index)t, pbwl__core_record(core, far))) {
            continue;
        }
        status = ++flips > most ? PBWL__REBUILD : pbwl__flip(core, t, k);
        if (status == PBW__DEFERRED) {
            status = PBWL__CORE_GROW(core, untested, core->untested_count + 1) ? PBW_OK : PBW_ERROR_MEMORY;
            if (status == PBW_OK) {
                core->untested[core->untested_count++] = facet;
                continue;
            }
        }
        if (status == PBW_OK && !PBWL__CORE_GROW(core, edge, count + 6)) {
            status = PBW_ERROR_MEMORY;
        }
        for (k = 0; k < 3 && status == PBW_OK; k++) {
            core->edge[count++] = (pbw__link)(4 * t + k);
            core->edge[count++] = (pbw__link)(4 * s + k);
        }
        if ((flips & 1023) == 0 && pbw__report(kernel->context, 0.5)) {
            status = PBW_CANCELLED;
        }
    }
    return status;
}

/* pbwl__flip_all, starting from the marks of a verification. */
static pbw_status pbwl__flip_marked(pbwl__core *core, size_t most)
{
    pbw__kernel *kernel = &core->kernel;
    size_t count = 0, t;
    unsigned k;
    for (t = 0; t < core->store.count; t++) {
        for (k = 0; k < 3 && kernel->mark[t] != 0 && kernel->corner[4 * t] != PBW_NONE; k++) {
            if (!PBWL__CORE_GROW(core, edge, count + 1)) {
                return PBW_ERROR_MEMORY;
            }
            core->edge[count] = (pbw__link)(4 * t + k);
            count += kernel->mark[t] >> k & 1;
        }
        kernel->mark[t] = 0;
    }
    return pbwl__flip_all(core, count, most);
}

/* After the records got other coordinates: PBW_OK if the core is their triangulation, in the plane after at most
   `most` flips; PBWL__REBUILD if not. */
static pbw_status pbwl__verify(pbwl__core *core, size_t most)
{
    pbw__context *context = core->kernel.context;
    pbwl__verifying verifying;
    pbw_status status;
    memset(&verifying, 0, sizeof(verifying));
    verifying.core = core;
    verifying.most = core->kernel.dim == 3 || core->kernel.weighted ? 0 : most;
    status = pbwl__choose_inside(&verifying) ? pbwl__verify_all(&verifying) : PBWL__REBUILD;
    if (status == PBW_OK && (verifying.inverted > 0 || verifying.failing > verifying.most)) {
        status = PBWL__REBUILD;
    } else if (status == PBW_OK && verifying.failing > 0) {
        verifying.covers = 0;
        status = pbwl__flip_marked(core, most);
        status = status != PBW_OK ? status : !pbwl__choose_inside(&verifying) ? PBWL__REBUILD
               : pbw__for_range(context, core->store.count, 16384, 1.0, pbwl__cover_range, &verifying);
    }
    if (status != PBW_OK) {
        pbw__set_bytes(context, core->kernel.mark, 0, core->store.count);
    }
    return status == PBW_OK && verifying.covers != 1 ? PBWL__REBUILD : status;
}
/* ------------------------------------------------------------------------------------------------------
   >>live         Points to insert, remove and move: the queue.
   In: a mesh, then changes by number.  Out: for >>commit, the points as they are to be.
   Holds: `point`, `weight` and `state` are as they will be after the next commit; the core is as the last one left
   it. A commit that fails changes neither: it works on another core, or undoes its changes, which needs no memory.
   ------------------------------------------------------------------------------------------------------ */
#define PBWL__COMMITTED 1u                           /* it is a point of the last commit */
#define PBWL__KEPT 2u                                /* it will be one of the next commit */
#define PBWL__QUEUED 4u                              /* its number is in the queue */
#define PBWL__OLD_PLACE 8u                           /* in a commit: it leaves its old place */
#define PBWL__NEW_PLACE 16u                          /* in a commit: it arrives at a new place */
#define PBWL__SEEN 32u                               /* while changes are queued: it is the number of one */

#define PBWL__GROW(live, x, needed) PBW__GROW(&(live)->core.kernel, live, x, needed)

/* A write to a table of the core, to be undone: the entry and its old value. */
typedef struct pbwl__edit { pbw_index table, at, old; } pbwl__edit;
enum { PBWL__EDIT_VERTEX, PBWL__EDIT_TWIN, PBWL__EDIT_PLACE };

struct pbw_live {
    pbw_memory memory;
    pbw_options options;
    pbw_threads *team;                               /* NULL: not started */
    size_t team_points;                              /* it has threads for so many */
    long process;                                    /* that started it */
    int dim, weighted, weighted_before;              /* weighted: from the next commit on; before: at the last one */
    double *point, *weight;                          /* per number */
    unsigned char *state;
    pbw_index *spare, *queue;                        /* numbers that are free; numbers with changes */
    size_t point_capacity, weight_capacity, state_capacity, spare_capacity, queue_capacity;
    size_t count, spare_count, queue_count;          /* count: numbers */
    size_t numbers, points;                          /* how many there were at the last commit */
    pbwl__core core;
    /* of one commit */
    pbwl__edit *edit;
    pbw_index *head, *leaving, *arriving;            /* head: per place that changes, a number; others: vertices */
    pbw_index *joining;                              /* numbers that arrive; then vertices that they did not need */
    double *moved;                                   /* the other coordinates of those in `leaving` */
    size_t edit_capacity, head_capacity, leaving_capacity, arriving_capacity, joining_capacity, moved_capacity;
    size_t edit_count, leaving_count, arriving_count, joining_count, first_edit;
    size_t joins;                                    /* numbers that arrive at the place of another one */
    size_t saved_vertices, saved_unused, saved_placed;
    pbw__grid saved_grid;
    double saved_height;
};

/* ---- threads, kept from call to call */
#if defined(PBW__THREADS) && !defined(_WIN32)
#define PBWL__PROCESS() ((long)getpid())
#else
#define PBWL__PROCESS() 0L
#endif

static void pbwl__team_stop(pbw_live *live)
{
#ifdef PBW__THREADS
    if (live->team != NULL && live->process != PBWL__PROCESS()) {    /* a fork has the memory but not the threads */
        pbw_memory memory = live->team->memory;
        pbw__release(&memory, live->team, 1, sizeof(pbw_threads));
        live->team = NULL;
    }
#endif
    pbw_threads_stop(live->team);
    live->team = NULL;
}

/* Begins a call on `count` points, but for its memory. */
static void pbwl__context_start(pbw_live *live, pbw__context *context, size_t count)
{
    pbw__context_start(context, &live->options, count);
#ifdef PBW__THREADS
    if (context->threads > 1 && context->options.run == NULL && context->team == NULL) {
        const size_t points = count > live->count ? count : live->count;
        if (live->team == NULL || live->process != PBWL__PROCESS() || live->team_points < points) {
            pbw_options options = live->options, inner;
            pbwl__team_stop(live);
            pbw_memory_nest(&live->memory, &options);
            live->team_points = 2 * points;
            live->process = PBWL__PROCESS();
            live->team = pbw_threads_start(&options, live->team_points, &inner);
        }
        context->team = live->team;                  /* if NULL, the call starts one of its own */
    }
#endif
}

/* ---- the queue */
PBW__INLINE const double *pbwl__point(const pbw_live *live, size_t id)
{
    return live->point + id * (size_t)live->dim;
}

/* Prefetches for later entries of the queue, which has no order. */
PBW__INLINE void pbwl__prefetch(const pbw_live *live, size_t i, size_t end)
{
    if (i + 32 < end) {
        const pbw_index far = live->queue[i + 32], near = live->queue[i + 16];
        PBW__PREFETCH(live->state + far);
        PBW__PREFETCH(live->point + (size_t)live->dim * far);
        if (live->core.vertex == NULL) {             /* the points span no simplex */
            return;
        }
        if (far < live->numbers) {
            PBW__PREFETCH(live->core.vertex + far);
        }
        if (near < live->numbers && (live->state[near] & PBWL__COMMITTED) != 0) {
            PBW__PREFETCH(pbwl__core_record(&live->core, live->core.vertex[near]));
            PBW__PREFETCH(live->core.link_index + live->core.vertex[near]);
        }
    }
}

/* Makes room for `count` numbers, `queued` of them in the queue. */
static pbw_status pbwl__reserve(pbw_live *live, size_t count, size_t queued)
{
    pbw_memory *memory = &live->memory;
    if (count >= PBW__POINT_LIMIT || count > (size_t)-1 / 256) {
        return PBW_ERROR_TOO_LARGE;
    }
    return pbw_memory_grow(memory, &live->point, &live->point_capacity, count * (size_t)live->dim, 0, sizeof(double))
        && pbw_memory_grow(memory, &live->weight, &live->weight_capacity, count, 0, sizeof(double))
        && pbw_memory_grow(memory, &live->state, &live->state_capacity, count, 0, 1)
        && pbw_memory_grow(memory, &live->spare, &live->spare_capacity, count, 0, sizeof(pbw_index))
        && pbw_memory_grow(memory, &live->queue, &live->queue_capacity, queued, 0, sizeof(pbw_index))
        ? PBW_OK : PBW_ERROR_MEMORY;
}

PBW__INLINE double pbwl__zero_if_finite(const double *x, size_t count)
{
    double sum = 0.0;
    size_t i;
    for (i = 0; i < count; i++) {
        sum += x[i] - x[i];
    }
    return sum;
}

PBW__INLINE int pbwl__all_finite(const double *x, size_t count)
{
    return pbwl__zero_if_finite(x, count) == 0.0;
}

/* What is being queued: insertions if `fresh`, else removals if points is NULL, else moves. */
typedef struct pbwl__queueing {
    pbw_live *live;
    const double *points, *weights;
    const pbw_index *ids;                            /* NULL: all numbers */
    pbw_index *new_ids;                              /* may be NULL */
    size_t spare;                                    /* numbers that insertions may take again */
    int fresh, mixed, twice;                         /* mixed: the numbers do not ascend, so some may be equal;
                                                        twice: some are */
} pbwl__queueing;

/* Returns the i-th number. */
PBW__INLINE size_t pbwl__queued_number(const pbwl__queueing *queueing, size_t i)
{
    const pbw_live *live = queueing->live;
    return !queueing->fresh ? (queueing->ids != NULL ? queueing->ids[i] : i)
         : i < queueing->spare ? live->spare[live->spare_count - 1 - i] : live->count + (i - queueing->spare);
}

/* Returns the status for a range of what is to be queued. */
PBW__INLINE pbw_status pbwl__queue_check_of(pbwl__queueing *queueing, size_t from, size_t to, int dims)
{
    const pbw_live *live = queueing->live;
    const pbw_index *ids = queueing->ids;
    const size_t dim = (size_t)dims;
    double sum = 0.0;
    size_t i;
    if (queueing->fresh) {
        return pbwl__all_finite(queueing->points + from * dim, (to - from) * dim)
            && (queueing->weights == NULL || pbwl__all_finite(queueing->weights + from, to - from))
             ? PBW_OK : PBW_ERROR_NOT_FINITE;
    }
    for (i = from; i < to; i++) {
        const size_t id = ids != NULL ? ids[i] : i;
        const int stays = id < live->count && (live->state[id] & PBWL__KEPT) != 0;
        if (!stays && ids != NULL) {
            return PBW_ERROR_ARGUMENT;
        }
        if (ids != NULL && i > 0 && ids[i - 1] >= id && !PBW__LOAD(&queueing->mixed)) {
            PBW__STORE(&queueing->mixed, 1);
        }
        sum += !stays || queueing->points == NULL ? 0.0 : pbwl__zero_if_finite(queueing->points + i * dim, dim);
    }
    return sum == 0.0 ? PBW_OK : PBW_ERROR_NOT_FINITE;
}

static pbw_status pbwl__queue_check(void *arg, size_t from, size_t to)
{
    pbwl__queueing *queueing = (pbwl__queueing *)arg;
    return PBW__BY_DIM(queueing->live->dim, pbwl__queue_check_of, queueing, from, to);
}

/* Marks the numbers of a range as seen; notes whether one was seen before. */
static pbw_status pbwl__queue_mark(void *arg, size_t from, size_t to)
{
    pbwl__queueing *queueing = (pbwl__queueing *)arg;
    unsigned char *state = queueing->live->state;
    for (; from < to && !PBW__LOAD(&queueing->twice); from++) {
        unsigned char *at = state + queueing->ids[from], old = PBW__LOAD(at);
        PBW__PREFETCH_TO_WRITE(state + queueing->ids[from + 16 < to ? from + 16 : from]);
        while ((old & PBWL__SEEN) == 0 && !PBW__CAS(at, &old, (unsigned char)(old | PBWL__SEEN))) {
        }
        if ((old & PBWL__SEEN) != 0) {
            PBW__STORE(&queueing->twice, 1);
        }
    }
    return PBW_OK;
}

/* Queues a range, and lists the numbers that are new in the queue. */
PBW__INLINE size_t pbwl__queue_range_of(const pbwl__queueing *queueing, size_t from, size_t to, size_t at, int dims)
{
    pbw_live *live = queueing->live;
    const double *points = queueing->points;
    const unsigned kept = points != NULL ? PBWL__KEPT : 0;
    const size_t dim = (size_t)dims;
    size_t found = 0, i, k;
    for (i = from; i < to; i++) {
        const size_t id = pbwl__queued_number(queueing, i);
        const unsigned state = queueing->fresh ? PBWL__KEPT : live->state[id];
        if ((state & PBWL__KEPT) == 0) {
            continue;                                /* a move of an unused number */
        }
        if (at != PBWL__COUNT) {
            for (k = 0; k < dim && kept; k++) {
                live->point[id * dim + k] = points[i * dim + k] + 0.0;       /* no -0.0 */
            }
            if ((state & PBWL__QUEUED) == 0) {
                live->queue[live->queue_count + at + found] = (pbw_index)id;
            }
            live->state[id] = (unsigned char)((state & ~(PBWL__KEPT | PBWL__SEEN)) | kept | PBWL__QUEUED);
        }
        if (at != PBWL__COUNT && queueing->fresh) {
            live->weight[id] = queueing->weights != NULL ? queueing->weights[i] + 0.0 : 0.0;
        }
        if (at != PBWL__COUNT && queueing->new_ids != NULL) {
            queueing->new_ids[i] = (pbw_index)id;
        }
        found += (state & PBWL__QUEUED) == 0;
    }
    return found;
}

static size_t pbwl__queue_range(void *arg, size_t from, size_t to, size_t at)
{
    const pbwl__queueing *queueing = (const pbwl__queueing *)arg;
    return PBW__BY_DIM(queueing->live->dim, pbwl__queue_range_of, queueing, from, to, at);
}

/* Queues `count` changes, all or nothing; numbers: how many there will be. */
static pbw_status pbwl__queue(pbwl__queueing *queueing, size_t count, size_t numbers)
{
    pbw_live *live = queueing->live;
    pbw__context context;
    pbw_status status = pbwl__reserve(live, numbers, live->queue_count + count);
    size_t i;
    if (status != PBW_OK) {
        return status;
    }
    pbwl__context_start(live, &context, count);
    context.options.progress = NULL;
    context.memory = live->memory;
    status = pbw__for_range(&context, count, PBW__SMALLER(4096), 0.0, pbwl__queue_check, queueing);
    if (status == PBW_OK && queueing->mixed && (queueing->points == NULL || context.threads > 1)) {
        (void)pbw__for_range(&context, count, PBW__SMALLER(4096), 0.0, pbwl__queue_mark, queueing);
    }
    if (queueing->twice && queueing->points == NULL) {
        for (i = 0; i < count; i++) {
            live->state[queueing->ids[i]] &= (unsigned char)~PBWL__SEEN;
        }
        status = PBW_ERROR_ARGUMENT;
    }
    if (status == PBW_OK) {                          /* of equal numbers the last point stays */
        live->queue_count += queueing->twice ? pbwl__queue_range(queueing, 0, count, 0)
                                             : pbwl__list(&context, count, pbwl__queue_range, queueing);
    }
    pbw__team_stop(&context);
    live->memory = context.memory;
    return status;
}

PBWDEF pbw_status pbw_live_insert(pbw_live *live, const double *points, const double *weights, size_t count,
                                  pbw_index *ids)
{
    pbwl__queueing queueing = { NULL, NULL, NULL, NULL, NULL, 0, 1, 0, 0 };
    size_t numbers;
    pbw_status status;
    if (live == NULL || (points == NULL && count != 0)) {
        return PBW_ERROR_ARGUMENT;
    }
    if (count > (size_t)-1 / 256) {
        return PBW_ERROR_TOO_LARGE;
    }
    queueing.live = live;
    queueing.points = points;
    queueing.weights = weights;
    queueing.new_ids = ids;
    queueing.spare = count < live->spare_count ? count : live->spare_count;
    numbers = live->count + (count - queueing.spare);
    status = pbwl__queue(&queueing, count, numbers);
    if (status == PBW_OK) {
        live->weighted |= weights != NULL;
        live->spare_count -= queueing.spare;
        live->count = numbers;
    }
    return status;
}

PBWDEF pbw_status pbw_live_remove(pbw_live *live, const pbw_index *ids, size_t count)
{
    pbwl__queueing queueing = { NULL, NULL, NULL, NULL, NULL, 0, 0, 0, 0 };
    if (live == NULL || (ids == NULL && count != 0) || count > live->count) {
        return PBW_ERROR_ARGUMENT;
    }
    queueing.live = live;
    queueing.ids = ids;
    return pbwl__queue(&queueing, count, live->count);
}

PBWDEF pbw_status pbw_live_move(pbw_live *live, const pbw_index *ids, const double *points, size_t count)
{
    pbwl__queueing queueing = { NULL, NULL, NULL, NULL, NULL, 0, 0, 0, 0 };
    if (live == NULL || (points == NULL && count != 0) || (ids == NULL && count != live->count)) {
        return PBW_ERROR_ARGUMENT;
    }
    queueing.live = live;
    queueing.points = points;
    queueing.ids = ids;
    return pbwl__queue(&queueing, count, live->count);
}

/* ------------------------------------------------------------------------------------------------------
   >>report       What a commit changed.
   In: the journals of a batch, or the cores before and after a rebuild.  Out: the simplices that were deleted and
   those that were made, sorted, and the points that have another star.
   Holds: no simplex is in both lists.
   ------------------------------------------------------------------------------------------------------ */
PBW__INLINE int pbwl__tuple_order(const pbw_index *a, const pbw_index *b, size_t corners)
{
    size_t i;
    for (i = 0; i + 1 < corners && a[i] == b[i]; i++) {
    }
    return (a[i] > b[i]) - (a[i] < b[i]);
}

static void pbwl__sift_tuple(pbw_index *heap, size_t root, size_t count, size_t corners)
{
    const size_t bytes = corners * sizeof(pbw_index);
    pbw_index item[4];
    size_t child;
    memcpy(item, heap + root * corners, bytes);
    while ((child = 2 * root + 1) < count) {
        child += child + 1 < count
                 && pbwl__tuple_order(heap + (child + 1) * corners, heap + child * corners, corners) > 0;
        if (pbwl__tuple_order(heap + child * corners, item, corners) <= 0) {
            break;
        }
        memcpy(heap + root * corners, heap + child * corners, bytes);
        root = child;
    }
    memcpy(heap + root * corners, item, bytes);
}

/* Sorts the simplices of one vertex by their corners: a heap sort, which needs no memory. */
static void pbwl__sort_tuples(pbw_index *tuple, size_t count, size_t corners)
{
    pbw_index last[4];
    size_t i;
    for (i = count / 2; i-- > 0; ) {
        pbwl__sift_tuple(tuple, i, count, corners);
    }
    for (i = count; i-- > 1; ) {
        memcpy(last, tuple + i * corners, corners * sizeof(pbw_index));
        memcpy(tuple + i * corners, tuple, corners * sizeof(pbw_index));
        memcpy(tuple, last, corners * sizeof(pbw_index));
        pbwl__sift_tuple(tuple, 0, i, corners);
    }
}

/* Rotates the corners of a simplex: the lowest first, in space the lowest of the others second. */
PBW__INLINE void pbwl__turn_tuple(pbw_index *v, int dim)
{
    const unsigned order = pbw__canonical_order(v, dim);
    pbw_index old[4];
    int k;
    memcpy(old, v, ((size_t)dim + 1) * sizeof(pbw_index));
    for (k = 0; k <= dim; k++) {
        v[k] = old[order >> 2 * k & 3];
    }
}

typedef struct pbwl__owned_changes { pbw_memory memory; size_t deleted, made, points; } pbwl__owned_changes;

/* Frees changes.  `memory` counts their bytes; NULL: the commit has ended. */
static void pbwl__changes_release(pbw_memory *memory, pbw_changes *changes)
{
    if (changes != NULL && changes->memory != NULL) {
        pbwl__owned_changes *owned = (pbwl__owned_changes *)changes->memory;
        pbw_memory own = owned->memory;
        memory = memory != NULL ? memory : &own;
        pbw__release(memory, (void *)(uintptr_t)changes->deleted, owned->deleted, sizeof(pbw_index));
        pbw__release(memory, (void *)(uintptr_t)changes->made, owned->made, sizeof(pbw_index));
        pbw__release(memory, (void *)(uintptr_t)changes->points, owned->points, sizeof(pbw_index));
        pbw__release(memory, owned, 1, sizeof(pbwl__owned_changes));
    }
    if (changes != NULL) {
        memset(changes, 0, sizeof(*changes));
    }
}

PBWDEF void pbw_changes_free(pbw_changes *changes)
{
    pbwl__changes_release(NULL, changes);
}

/* A list of simplices that is being sorted. */
typedef struct pbwl__tuples {
    pbw_index *tuple, *sorted;
    uint64_t *key;                                   /* the lowest corner, and below it the index in `tuple` */
    uint32_t *digit;
    size_t count;
    int dim;
} pbwl__tuples;

static pbw_status pbwl__tuples_turn(void *arg, size_t from, size_t to)
{
    pbwl__tuples *tuples = (pbwl__tuples *)arg;
    const size_t corners = (size_t)tuples->dim + 1;
    size_t i;
    for (i = from; i < to; i++) {
        pbwl__turn_tuple(tuples->tuple + i * corners, tuples->dim);
        tuples->key[i] = (uint64_t)tuples->tuple[i * corners] << 32 | i;
    }
    return PBW_OK;
}

/* Copies the simplices of each lowest corner that first occurs in this range, and sorts them. */
static pbw_status pbwl__tuples_gather(void *arg, size_t from, size_t to)
{
    const pbwl__tuples *tuples = (const pbwl__tuples *)arg;
    const uint64_t *key = tuples->key;
    const size_t corners = (size_t)tuples->dim + 1, count = tuples->count;
    size_t i = from, first;
    while (i > 0 && i < to && key[i] >> 32 == key[i - 1] >> 32) {
        i++;
    }
    for (first = i; first < to; first = i) {
        do {
            PBW__PREFETCH(tuples->tuple + (uint32_t)key[i + 16 < count ? i + 16 : i] * corners);
            memcpy(tuples->sorted + i * corners, tuples->tuple + (uint32_t)key[i] * corners,
                   corners * sizeof(pbw_index));
        } while (++i < count && key[i] >> 32 == key[first] >> 32);
        pbwl__sort_tuples(tuples->sorted + first * corners, i - first, corners);
    }
    return PBW_OK;
}

/* Two sorted lists, cut where the lowest corner of simplices changes.  mark: a bit for each point. */
#define PBWL__MOST_CUTS 64
typedef struct pbwl__differing {
    pbw_index *tuple[2];
    size_t from[2][PBWL__MOST_CUTS + 1], kept[2][PBWL__MOST_CUTS], corners;
    uint64_t *mark;
} pbwl__differing;

/* Keeps in each of two sorted lists what is not in the other, of one cut; marks the points of both. */
static void pbwl__differ_cut(void *arg, int cut)
{
    pbwl__differing *differing = (pbwl__differing *)arg;
    const size_t corners = differing->corners, i_end = differing->from[0][cut + 1];
    const size_t j_end = differing->from[1][cut + 1];
    size_t i = differing->from[0][cut], j = differing->from[1][cut], k, to[2];
    to[0] = i;
    to[1] = j;
    while (i < i_end || j < j_end) {
        const int order = i == i_end ? 1 : j == j_end ? -1
                        : pbwl__tuple_order(differing->tuple[0] + i * corners, differing->tuple[1] + j * corners,
                                            corners);
        const size_t which = order > 0;
        if (order != 0) {
            const pbw_index *from = differing->tuple[which] + (order > 0 ? j : i) * corners;
            for (k = 0; k < corners; k++) {
                const uint64_t bit = (uint64_t)1 << from[k] % 64;
                uint64_t *word = differing->mark + from[k] / 64, old = PBW__LOAD(word);
                while ((old & bit) == 0 && !PBW__CAS(word, &old, old | bit)) {
                }
            }
            memmove(differing->tuple[which] + to[which]++ * corners, from, corners * sizeof(pbw_index));
        }
        i += order <= 0;
        j += order >= 0;
    }
    differing->kept[0][cut] = to[0] - differing->from[0][cut];
    differing->kept[1][cut] = to[1] - differing->from[1][cut];
}

/* Returns how many simplices of a sorted list have a lowest corner below `corner`: a binary search. */
static size_t pbwl__tuples_below(const pbw_index *tuple, size_t count, size_t corners, pbw_index corner)
{
    size_t from = 0;
    while (from < count) {
        const size_t middle = from + (count - from) / 2;
        if (tuple[middle * corners] < corner) {
            from = middle + 1;
        } else {
            count = middle;
        }
    }
    return from;
}

/* Keeps in each of two sorted lists what is not in the other; marks the points of both. */
static void pbwl__changes_differ(pbw__context *context, pbw_changes *changes, size_t corners, uint64_t *mark)
{
    const size_t count[2] = { changes->deleted_count, changes->made_count };
    const size_t longer = count[1] > count[0];
    const int tasks = pbw__tasks(context, count[longer], 16384);
    const int cuts = tasks < PBWL__MOST_CUTS ? tasks : PBWL__MOST_CUTS;
    pbwl__differing differing;
    size_t kept[2] = { 0, 0 }, k;
    int cut;
    differing.tuple[0] = (pbw_index *)(uintptr_t)changes->deleted;
    differing.tuple[1] = (pbw_index *)(uintptr_t)changes->made;
    differing.corners = corners;
    differing.mark = mark;
    for (k = 0; k < 2; k++) {
        differing.from[k][0] = 0;
        differing.from[k][cuts] = count[k];
        for (cut = 1; cut < cuts; cut++) {
            const size_t at = pbw__share(count[longer], cut, cuts);
            differing.from[k][cut] = pbwl__tuples_below(differing.tuple[k], count[k], corners,
                                                        differing.tuple[longer][at * corners]);
        }
    }
    pbw__for(context, cuts, pbwl__differ_cut, &differing);
    for (cut = 0; cut < cuts; cut++) {
        for (k = 0; k < 2; k++) {
            pbw_index *tuple = differing.tuple[k];
            const size_t from = differing.from[k][cut], more = differing.kept[k][cut];
            if (kept[k] < from && more > 0) {
                memmove(tuple + kept[k] * corners, tuple + from * corners, more * corners * sizeof(pbw_index));
            }
            kept[k] += more;
        }
    }
    changes->deleted_count = kept[0];
    changes->made_count = kept[1];
}

/* Returns the number of the lowest bit that is set. */
PBW__INLINE unsigned pbwl__first_bit(uint64_t set)
{
#ifdef __GNUC__
    return (unsigned)__builtin_ctzll(set);
#else
    unsigned i;
    for (i = 0; (set >> i & 1) == 0; i++) {
    }
    return i;
#endif
}

typedef struct pbwl__marks { const uint64_t *mark; pbw_index *points; } pbwl__marks;

/* Lists the marked numbers of a range of words; where `points` is NULL, only counts them. */
static size_t pbwl__list_marked(void *arg, size_t from, size_t to, size_t at)
{
    const pbwl__marks *marks = (const pbwl__marks *)arg;
    size_t found = 0, i;
    uint64_t rest;
    for (i = from; i < to; i++) {
        for (rest = marks->mark[i]; rest != 0; rest &= rest - 1) {
            if (at != PBWL__COUNT && marks->points != NULL) {
                marks->points[at + found] = (pbw_index)(64 * i) + (pbw_index)pbwl__first_bit(rest);
            }
            found++;
        }
    }
    return found;
}

/* Lists the marked numbers. */
static pbw_status pbwl__changes_points(pbw__context *context, pbw_changes *changes, const uint64_t *mark,
                                       size_t words)
{
    pbwl__owned_changes *owned = (pbwl__owned_changes *)changes->memory;
    pbwl__marks marks = { mark, NULL };
    changes->point_count = pbwl__list(context, words, pbwl__list_marked, &marks);
    marks.points = (pbw_index *)pbw__allocate(&context->memory, changes->point_count + 1, sizeof(pbw_index));
    if (marks.points == NULL) {
        return PBW_ERROR_MEMORY;
    }
    owned->points = changes->point_count + 1;
    changes->points = marks.points;
    (void)pbwl__list(context, words, pbwl__list_marked, &marks);
    return PBW_OK;
}

/* Sorts one list, in an array of *room words, with numbers below `numbers`, into a new array that just fits. */
static pbw_status pbwl__changes_sort(pbw__context *context, const pbw_index **list, size_t *room,
                                     pbwl__tuples *tuples, size_t numbers)
{
    pbw_memory *memory = &context->memory;
    const size_t count = tuples->count, words = count * ((size_t)tuples->dim + 1) + 1;
    const int bits = pbw__index_bits(numbers);
    uint64_t *key = (uint64_t *)pbw__allocate_large(context, count, sizeof(uint64_t));
    uint64_t *spare = (uint64_t *)pbw__allocate_large(context, count, sizeof(uint64_t));
    pbw__sorting sorting = { context, key, spare, tuples->digit, count, context->threads, 0, 0 };
    pbw_status status = PBW_ERROR_MEMORY;
    tuples->key = key;
    tuples->tuple = (pbw_index *)(uintptr_t)*list;
    tuples->sorted = (pbw_index *)pbw__allocate(memory, words, sizeof(pbw_index));
    if (key != NULL && spare != NULL && tuples->sorted != NULL) {
        status = pbw__for_range(context, count, 8192, 0.0, pbwl__tuples_turn, tuples);
    }
    if (status == PBW_OK) {
        tuples->key = count < PBW__TICK ? pbw__sort_keys(&sorting, 32, bits) : pbw__sort_by(&sorting, 32, bits);
        status = tuples->key == NULL ? PBW_CANCELLED
               : pbw__for_range(context, count, PBW__SMALLER(8192), 0.0, pbwl__tuples_gather, tuples);
    }
    pbw__release(memory, key, count, sizeof(uint64_t));
    pbw__release(memory, spare, count, sizeof(uint64_t));
    if (tuples->sorted != NULL) {
        pbw__release(memory, tuples->tuple, *room, sizeof(pbw_index));
        *list = tuples->sorted;
        *room = words;
    }
    return status;
}

/* Sorts both lists, deleted and made, with numbers below `numbers`, and keeps in them what differs. */
static pbw_status pbwl__changes_close(pbw__context *context, pbw_changes *changes, int dim, size_t numbers)
{
    pbwl__owned_changes *owned = (pbwl__owned_changes *)changes->memory;
    const size_t words = numbers / 64 + 1, digits = ((size_t)context->threads + 1) * PBW__DIGITS;
    uint64_t *mark = (uint64_t *)pbw__allocate(&context->memory, words, sizeof(uint64_t));
    uint32_t *digit = (uint32_t *)pbw__allocate(&context->memory, digits, sizeof(uint32_t));
    pbw_status status = mark == NULL || digit == NULL ? PBW_ERROR_MEMORY : PBW_OK;
    pbwl__tuples tuples = { NULL, NULL, NULL, NULL, 0, 0 };
    tuples.digit = digit;
    tuples.dim = dim;
    if (status == PBW_OK) {
        tuples.count = changes->deleted_count;
        status = pbwl__changes_sort(context, &changes->deleted, &owned->deleted, &tuples, numbers);
    }
    if (status == PBW_OK) {
        tuples.count = changes->made_count;
        status = pbwl__changes_sort(context, &changes->made, &owned->made, &tuples, numbers);
    }
    if (status == PBW_OK) {
        memset(mark, 0, words * sizeof(uint64_t));
        pbwl__changes_differ(context, changes, (size_t)dim + 1, mark);
        status = pbwl__changes_points(context, changes, mark, words);
    }
    pbw__release(&context->memory, mark, words, sizeof(uint64_t));
    pbw__release(&context->memory, digit, digits, sizeof(uint32_t));
    return status;
}

/* Makes room for so many deleted and made simplices. */
static pbw_status pbwl__changes_start(const pbw_live *live, pbw_changes *changes, size_t deleted, size_t made)
{
    const size_t corners = (size_t)live->dim + 1;
    pbw_memory *memory = &live->core.kernel.context->memory;
    pbwl__owned_changes *owned = (pbwl__owned_changes *)pbw__allocate(memory, 1, sizeof(*owned));
    if (owned == NULL) {
        return PBW_ERROR_MEMORY;
    }
    changes->memory = owned;
    owned->memory = *memory;
    owned->points = 0;
    owned->deleted = deleted * corners + 1;
    owned->made = made * corners + 1;
    changes->deleted = (pbw_index *)pbw__allocate(memory, owned->deleted, sizeof(pbw_index));
    changes->made = (pbw_index *)pbw__allocate(memory, owned->made, sizeof(pbw_index));
    return changes->deleted != NULL && changes->made != NULL ? PBW_OK : PBW_ERROR_MEMORY;
}

/* What is listed: simplices that a journal saved, as they were or as they are now in their slots; those in slots that
   were free; or all of a core.  list: gets the numbers of their corners. */
typedef struct pbwl__change_list {
    pbwl__core *core;
    int what;
    pbw_index *list;
} pbwl__change_list;
enum { PBWL__SAVED, PBWL__REMADE, PBWL__USED, PBWL__ALL };

/* Lists the finite ones of simplices from..to-1, counted through all journals or all slots. */
static size_t pbwl__list_changes(void *arg, size_t from, size_t to, size_t at)
{
    const pbwl__change_list *change = (const pbwl__change_list *)arg;
    pbwl__core *core = change->core, *own = core;
    const size_t dim = (size_t)core->kernel.dim;
    size_t journal = 0, first = 0, found = 0, i, k;
    for (i = from; i < to; i++) {
        size_t t = i;
        const pbw_index *v;
        while (change->what != PBWL__ALL
               && i - first >= (change->what == PBWL__USED ? own->used_slot_count : own->saved_count)) {
            first += change->what == PBWL__USED ? own->used_slot_count : own->saved_count;
            own = pbwl__journal(core, ++journal);
        }
        if (change->what != PBWL__ALL) {
            t = change->what == PBWL__USED ? own->used_slot[i - first] : own->saved[i - first].slot;
        }
        v = change->what == PBWL__SAVED ? own->saved[i - first].corner : core->store.corner + 4 * t;
        if (v[0] != PBW_NONE && v[dim] != PBW__GHOST) {
            for (k = 0; k <= dim && at != PBWL__COUNT; k++) {
                change->list[(at + found) * (dim + 1) + k] = core->name[v[k]];
            }
            found++;
        }
    }
    return found;
}

/* Adds changes to a list that has *count simplices. */
static void pbwl__changes_add(pbw__context *context, pbwl__core *core, int what, size_t items, const pbw_index *list,
                              size_t *count)
{
    pbwl__change_list change;
    change.core = core;
    change.what = what;
    change.list = (pbw_index *)(uintptr_t)list + *count * ((size_t)core->kernel.dim + 1);
    *count += pbwl__list(context, items, pbwl__list_changes, &change);
}

/* Lists the changes of a batch, from the journals. */
static pbw_status pbwl__batch_changes(pbw_live *live, pbw_changes *changes)
{
    pbwl__core *core = &live->core;
    pbw__context *context = core->kernel.context;
    size_t saved = 0, taken = 0, j;
    pbw_status status;
    for (j = 0; j <= core->tasks; j++) {
        saved += pbwl__journal(core, j)->saved_count;
        taken += pbwl__journal(core, j)->used_slot_count;
    }
    status = pbwl__changes_start(live, changes, saved, saved + taken);
    if (status != PBW_OK) {
        return status;
    }
    pbwl__changes_add(context, core, PBWL__SAVED, saved, changes->deleted, &changes->deleted_count);
    pbwl__changes_add(context, core, PBWL__REMADE, saved, changes->made, &changes->made_count);
    pbwl__changes_add(context, core, PBWL__USED, taken, changes->made, &changes->made_count);
    return pbwl__changes_close(context, changes, live->dim, live->count);
}

/* Lists the changes from the live core to another one. */
static pbw_status pbwl__rebuild_changes(pbw_live *live, pbwl__core *core, pbw_changes *changes)
{
    pbwl__core *old = &live->core;
    pbw__context *context = old->kernel.context;
    pbw_status status = pbwl__changes_start(live, changes, old->simplex_count, core->simplex_count);
    if (status != PBW_OK) {
        return status;
    }
    pbwl__changes_add(context, old, PBWL__ALL, old->simplex_count > 0 ? old->store.count : 0, changes->deleted,
                      &changes->deleted_count);
    pbwl__changes_add(context, core, PBWL__ALL, core->simplex_count > 0 ? core->store.count : 0, changes->made,
                      &changes->made_count);
    return pbwl__changes_close(context, changes, live->dim, live->count);
}

/* ------------------------------------------------------------------------------------------------------
   >>hints        Where walks start, and what batches prefetch.
   In: the vertices of a batch, along the curve.  Out: for each a simplex near it; the stars that are needed soon, in
   the cache, as those of a small batch are cold.
   Holds: any simplex may be a hint; an outdated one makes a walk longer, never wrong.  The table is a grid
   on the box of all vertices, with one cell for two vertices; each cell has a vertex that is or was in it.
   ------------------------------------------------------------------------------------------------------ */
PBW__INLINE size_t pbwl__start_cell(const pbwl__core *core, const double *x)
{
    const int dim = core->kernel.dim;
    size_t cell = 0;
    int k;
    for (k = dim; k-- > 0; ) {
        const double at = (x[k] - core->start_low[k]) * core->start_scale[k];
        const double side = (double)(core->start_side - 1);
        cell = cell * core->start_side + (size_t)(at > 0.0 ? at < side ? at : side : 0.0);
    }
    return cell;
}

static pbw_status pbwl__start_fill(void *arg, size_t from, size_t to)
{
    pbwl__core *core = (pbwl__core *)arg;
    for (from++, to++; from < to; from++) {
        if (core->incident[from] < PBWL__VERTEX_REMOVED) {
            const double *x = pbwl__core_record(core, (pbw_index)from);
            PBW__STORE(core->start + pbwl__start_cell(core, x), (pbw_index)from);
        }
    }
    return PBW_OK;
}

/* Makes the table of starts: at once if there are `tasks`, else after n^(1/2) / 8 walks among n vertices, which take
   about as long as the table.  Makes it again after n walks, as vertices move and are added. */
static void pbwl__start_table(pbwl__core *core, size_t walks, int tasks)
{
    const size_t cells = core->vertex_count / 2 + 1;
    size_t side = 1, all;
    int k;
    core->searched += walks;
    if (core->start != NULL ? core->searched < core->vertex_count
                            : !tasks && 64 * core->searched * core->searched < core->vertex_count) {
        return;
    }
    core->searched = 0;
    while ((side + 1) * (side + 1) * (core->kernel.dim == 3 ? side + 1 : 1) <= cells) {
        side++;
    }
    all = side * side * (core->kernel.dim == 3 ? side : 1);
    if (!PBWL__CORE_GROW(core, start, all)) {
        return;                                      /* walks start as before */
    }
    core->start_side = side;
    for (k = 0; k < core->kernel.dim; k++) {
        const double scale = (double)side / (core->high[k] - core->low[k]);
        core->start_low[k] = core->low[k];
        core->start_scale[k] = scale > 0.0 && scale <= DBL_MAX ? scale : 0.0;
    }
    pbw__set_bytes(core->kernel.context, core->start, 0, core->start_capacity * sizeof(pbw_index));
    (void)pbw__for_range(core->kernel.context, core->vertex_count, 16384, 0.0, pbwl__start_fill, core);
}

/* Lets walks that would start from v, which was just removed, start from a vertex of its link. */
PBW__INLINE void pbwl__start_leave(const pbwl__core *core, pbw_index v)
{
    pbw_index *start = core->start + pbwl__start_cell(core, pbwl__core_record(core, v));
    if (PBW__LOAD(start) == v) {
        PBW__STORE(start, core->link_vertex[core->link_vertices - 1]);
    }
}

/* Prefetches, step by step: (0) a simplex of v; (1) its vertices and its neighbours at v; (2) the vertices of these
   and the simplices behind them; (3) the vertices of the latter.  A task that owns v may read all this. */
PBW__INLINE void pbwl__prefetch_star(const pbwl__core *core, pbw_index v, int step)
{
    const size_t dim = (size_t)core->kernel.dim, width = dim + 1, t = core->incident[v];
    const pbw_index *corner = core->kernel.corner;
    const pbw__link *link = core->kernel.link;
    size_t k, m;
    if (step == 0) {
        PBW__PREFETCH(corner + 4 * t);
        PBW__PREFETCH(link + 4 * t);
        PBW__PREFETCH(core->kernel.mark + t);
        return;
    }
    for (k = 0; k <= dim; k++) {
        size_t u;
        if (corner[4 * t + k] == v) {
            continue;
        }
        u = link[4 * t + k] >> 2;
        if (step == 1) {
            PBW__PREFETCH(core->record + width * corner[4 * t + k]);
            PBW__PREFETCH(corner + 4 * u);
            PBW__PREFETCH(link + 4 * u);
            PBW__PREFETCH(core->kernel.mark + u);
            continue;
        }
        for (m = 0; m <= dim; m++) {
            pbw__link behind;
            if (corner[4 * u + m] == v) {
                continue;
            }
            behind = link[4 * u + m];
            if (step == 2) {
                PBW__PREFETCH(core->record + width * corner[4 * u + m]);
                PBW__PREFETCH(corner + behind);
                PBW__PREFETCH(link + behind);
                PBW__PREFETCH(core->kernel.mark + (behind >> 2));
            } else {
                PBW__PREFETCH(core->record + width * corner[behind]);
                PBW__PREFETCH(core->link_index + corner[behind]);
            }
        }
    }
}

/* Returns the nearer to p of two vertices, of those from which this thread may start; 0 if there is none. */
PBW__INLINE pbw_index pbwl__nearer_start(pbwl__core *core, pbw_index a, pbw_index b, const double *p)
{
    const int dim = core->kernel.dim;
    const int has_a = a != 0 && pbwl__hold(&core->kernel, a) && core->incident[a] < PBWL__VERTEX_REMOVED;
    if (b == 0 || b == a || !pbwl__hold(&core->kernel, b) || core->incident[b] >= PBWL__VERTEX_REMOVED) {
        return has_a ? a : 0;
    }
    return has_a
        && pbw__squared(pbwl__core_record(core, a), p, dim) <= pbw__squared(pbwl__core_record(core, b), p, dim)
         ? a : b;
}

/* ------------------------------------------------------------------------------------------------------
   >>tasks        A batch of changes by many threads.
   In: a core, changes to its vertices, in any order.  Out: the core with the changes.
   Holds: the invariants of >>core.  The triangulation of the points is unique, so the order of changes does not
   matter.

   A task takes blocks of its share of the changes along the curve, and works in small groups: it claims a vertex
   near each change, prefetches the stars of these, then makes the changes.  For each change it claims the vertices
   that it needs, as in >>parallel, but a zone is one vertex here.  After each group it releases all of them.  A
   change that needs a vertex of another task is put off to the end of the task, then to the next round.  One thread
   makes the last ones.

   No data races: the rule is stricter than in >>parallel.  Only a task that owns all finite vertices of a simplex
   deletes it.  So
     (a) if a task owns one vertex of a simplex, no other task deletes this simplex, or changes its links across
     facets that have this vertex;
     (b) only the owner of a vertex reads and writes its incident simplex: a task owns all corners of the simplices
     that it makes, but for the ghost;
     (c) only a task that owns all vertices of a star changes the coordinates of its centre.  A task that reads the
     coordinates of a vertex owns it, or owns another vertex of a simplex of that star; or no coordinates change in
     this batch;
     (d) marks and slots, acquire and release are as in >>parallel.
   The ghost has no owner: the task that owns the other vertices of a ghost simplex deletes it.
   ------------------------------------------------------------------------------------------------------ */
#define PBWL__GROUP 8                                /* changes that are claimed and prefetched together */
#define PBWL__LEAST_CHANGES 256                      /* in the first round a task must have so many to pay off, */
#define PBWL__LEAST_LEFT 64                          /* in later ones, where the threads run already, so many */

typedef struct pbwl__changing {
    void *arg;
    /* near: returns a vertex near the i-th change, or 0.  change: makes it; on PBW__DEFERRED nothing has changed. */
    pbw_index (*near)(void *arg, pbwl__core *core, size_t i);
    pbw_status (*change)(void *arg, pbwl__core *core, size_t i, pbw_index near);
    size_t count, slots, most_effort;                /* slots: per change; a task without free ones stops */
    size_t deleted;                                  /* simplices that a change deletes, roughly */
    double begin, end;                               /* of the stage's progress */
    int once;                                        /* only the first round: others are left for another change */
    /* of a round */
    pbwl__core *core;
    const pbw_index *which;                          /* the changes of this round; NULL: all */
    size_t round_count, grain;                       /* grain: changes of a block */
    int parts, stop;
    int backwards;                                   /* the first task has the last share */
    uint32_t taken[PBW__NOBODY];                     /* per share: blocks taken from the front, from the back << 16 */
    uint8_t *owner;                                  /* of each vertex: nobody between rounds */
} pbwl__changing;

/* Makes a group of changes; those that cannot be made now go to kernel.left. */
static pbw_status pbwl__batch_group(const pbwl__changing *batch, pbwl__core *core, const pbw_index *which,
                                    size_t from, size_t to)
{
    pbw__kernel *kernel = &core->kernel;
    const size_t count = to - from < PBWL__GROUP ? to - from : PBWL__GROUP;
    pbw_index at[PBWL__GROUP], near[PBWL__GROUP];
    pbw_status status = PBW_OK;
    size_t i;
    int step;
    for (i = 0; i < count; i++) {
        at[i] = which != NULL ? which[from + i] : (pbw_index)(from + i);
        near[i] = batch->near(batch->arg, core, at[i]);
        near[i] = near[i] != 0 && pbwl__hold(kernel, near[i]) && core->incident[near[i]] < PBWL__VERTEX_REMOVED
                ? near[i] : 0;
    }
    for (step = 0; step < 4; step++) {
        for (i = 0; i < count; i++) {
            if (near[i] != 0) {
                pbwl__prefetch_star(core, near[i], step);
            }
        }
    }
    for (i = 0; i < count && status == PBW_OK; i++) {
        status = kernel->slots.no_room ? PBW__DEFERRED : batch->change(batch->arg, core, at[i], near[i]);
        if (status == PBW__DEFERRED) {
            status = PBW__GROW(kernel, kernel, left, kernel->left_count + 1) ? PBW_OK : PBW_ERROR_MEMORY;
            if (status == PBW_OK) {
                kernel->left[kernel->left_count++] = at[i];
            }
        }
        status = status == PBW_OK && core->effort > batch->most_effort ? PBWL__REBUILD : status;
    }
    return status;
}

/* Makes changes from..to-1 of a list, which may be kernel.left itself.  Releases the vertices that it claims, unless
   a change fails. */
static pbw_status pbwl__batch_range(const pbwl__changing *batch, pbwl__core *core, const pbw_index *which,
                                    size_t from, size_t to)
{
    pbw__ownership *own = &core->kernel.own;
    pbw_status status = PBW_OK;
    double done;
    size_t i;
    for (i = from; i < to && status == PBW_OK && !PBW__LOAD(&batch->stop); i += PBWL__GROUP) {
        status = pbwl__batch_group(batch, core, which, i, to);
        while (status == PBW_OK && own->owner != NULL && own->claim_count > 0) {     /* else a star is unfinished */
            PBW__STORE_RELEASE(own->owner + own->claim[--own->claim_count], PBW__NOBODY);
            PBW__TEST_PAUSE();
        }
        core->handled += PBWL__GROUP;
        done = (double)core->handled * (double)batch->parts / (double)batch->round_count;
        done = batch->begin + (batch->end - batch->begin) * (done < 1.0 ? done : 1.0);
        if (status == PBW_OK && pbw__report(core->kernel.context, done)) {
            status = PBW_CANCELLED;
        }
    }
    return status;
}

/* Makes room in a journal for so many changes at once, if there is memory for it: growing piece by piece copies it
   time and again. */
static void pbwl__journal_expect(const pbwl__changing *batch, pbwl__core *core, size_t count)
{
    (void)PBWL__CORE_GROW(core, saved, core->saved_count + batch->deleted * count);
    (void)PBWL__CORE_GROW(core, used_slot, core->used_slot_count + batch->slots * count);
}

/* Sets the range of those changes of a share that no task has taken, by the share's word `taken`.  Returns how many
   blocks they are. */
static size_t pbwl__batch_rest(const pbwl__changing *batch, int share, uint32_t taken, size_t *from, size_t *to)
{
    const size_t begin = pbw__share(batch->round_count, share, batch->parts);
    const size_t end = pbw__share(batch->round_count, share + 1, batch->parts);
    const size_t blocks = (end - begin + batch->grain - 1) / batch->grain;
    const size_t front = taken & 65535, back = taken >> 16;
    *from = begin + front * batch->grain;
    *to = back == 0 ? end : begin + (blocks - back) * batch->grain;
    return blocks - front - back;
}

/* Takes a block of changes for a task: from the front of its own share, then from the back of others', where no task
   is at work.  Returns 0 if none is left.  So a task removes and inserts in one place, with slots from there. */
static int pbwl__batch_take(pbwl__changing *batch, int part, size_t *from, size_t *to)
{
    const int own = batch->backwards ? batch->parts - 1 - part : part;
    int k;
    for (k = 0; k < batch->parts; k++) {
        const int share = (own + k) % batch->parts;
        uint32_t taken = PBW__LOAD(batch->taken + share);
        size_t blocks;
        while ((blocks = pbwl__batch_rest(batch, share, taken, from, to)) > 0) {
            if (PBW__CAS(batch->taken + share, &taken, taken + (k == 0 ? 1 : 65536))) {
                if (k == 0) {
                    *to = blocks > 1 ? *from + batch->grain : *to;
                } else {
                    *from += (blocks - 1) * batch->grain;
                }
                return 1;
            }
        }
    }
    return 0;
}

static void pbwl__batch_task(void *arg, int part)
{
    pbwl__changing *batch = (pbwl__changing *)arg;
    pbwl__core *core = batch->core->task[part];
    pbw__kernel *kernel = &core->kernel;
    size_t from, to, count;
    pbwl__journal_expect(batch, core, batch->round_count / (size_t)batch->parts);
    while (kernel->status == PBW_OK && !PBW__LOAD(&batch->stop) && !kernel->slots.no_room   /* others may have room */
           && pbwl__batch_take(batch, part, &from, &to)) {
        kernel->status = pbwl__batch_range(batch, core, batch->which, from, to);
    }
    count = kernel->left_count;
    kernel->left_count = 0;                          /* once more: other tasks have moved on */
    if (kernel->status == PBW_OK) {
        kernel->status = pbwl__batch_range(batch, core, kernel->left, 0, count);
    }
    if (kernel->status != PBW_OK) {
        PBW__STORE(&batch->stop, 1);
    }
}

/* Moves up to `count` free slots from one core to another; core: the main one. */
static void pbwl__move_slots(const pbwl__core *core, pbwl__core *from, pbwl__core *to, size_t count)
{
    pbw__slots *source = &from->kernel.slots, *slots = &to->kernel.slots;
    for (; count > 0 && source->free_count > 0; count--, source->free_count--) {
        const pbw_index t = source->free_list;
        source->free_list = core->kernel.corner[4 * (size_t)t + 1];
        core->kernel.corner[4 * (size_t)t + 1] = slots->free_list;
        slots->free_list = t;
        slots->free_last = slots->free_count++ == 0 ? t : slots->free_last;
    }
}

/* Gives free slots to the tasks of a round.  Each keeps its own from batch to batch, and takes what it lacks from the
   tail of the store, as walking a list takes time.  What the tail lacks comes from the core's list, then from tasks
   with more than they need. */
static void pbwl__share_slots(const pbwl__changing *batch)
{
    pbwl__core *core = batch->core;
    const size_t parts = (size_t)batch->parts, wanted = batch->slots * (batch->round_count / parts) + 64;
    const size_t tail = core->store.capacity - core->store.count;
    size_t missing = 0, part;
    for (part = 0; part < parts; part++) {
        const size_t have = core->task[part]->kernel.slots.free_count;
        missing += have < wanted ? wanted - have : 0;
    }
    missing = missing > tail ? missing - tail : 0;
    for (part = core->tasks; part-- > 0 && missing > core->kernel.slots.free_count; ) {
        const size_t have = core->task[part]->kernel.slots.free_count, needs = part < parts ? wanted : 0;
        const size_t surplus = have > needs ? have - needs : 0, more = missing - core->kernel.slots.free_count;
        pbwl__move_slots(core, core->task[part], core, surplus < more ? surplus : more);
    }
    for (part = 0; part < parts && missing > 0; part++) {
        const size_t have = core->task[part]->kernel.slots.free_count;
        const size_t share = missing / (parts - part), less = have < wanted ? wanted - have : 0;
        pbwl__move_slots(core, core, core->task[part], less < share ? less : share);
        missing -= core->task[part]->kernel.slots.free_count - have;
    }
}

/* Lets a task's core use the arrays of the main core. */
static void pbwl__task_begin(const pbwl__changing *batch, int part)
{
    pbwl__core *core = batch->core, *task = core->task[part];
    pbw__kernel *kernel = &task->kernel, *main = &core->kernel;
    memcpy(task, core, offsetof(pbwl__core, kernel));
    memcpy(&kernel->context, &main->context, offsetof(pbw__kernel, slots) - offsetof(pbw__kernel, context));
    kernel->last = PBW_NONE;
    kernel->previous = kernel->vertex_count = 0;
    kernel->journal = task;
    kernel->left_count = 0;
    kernel->status = PBW_OK;
    kernel->own.owner = batch->owner;
    kernel->own.me = (uint8_t)part;
    kernel->own.owner_bits = kernel->own.claim_count = 0;
    kernel->slots.no_room = 0;
    task->simplex_count = task->effort = task->reinserted = task->handled = task->untested_count = 0;
}

/* Adds up what a task counted, and collects the changes that it left. */
static pbw_status pbwl__task_end(pbwl__core *core, pbwl__core *task)
{
    const pbw__kernel *kernel = &task->kernel;
    pbw__kernel *main = &core->kernel;
    core->simplex_count += task->simplex_count;
    core->effort += task->effort;
    core->reinserted += task->reinserted;
    if (!PBW__GROW(main, main, left, main->left_count + kernel->left_count)
        || !PBWL__CORE_GROW(core, untested, core->untested_count + task->untested_count)) {
        return PBW_ERROR_MEMORY;
    }
    if (kernel->left_count > 0) {
        memcpy(main->left + main->left_count, kernel->left, kernel->left_count * sizeof(pbw_index));
    }
    if (task->untested_count > 0) {
        memcpy(core->untested + core->untested_count, task->untested, task->untested_count * sizeof(pbw__link));
    }
    main->left_count += kernel->left_count;
    core->untested_count += task->untested_count;
    return kernel->status;
}

/* Lists the changes that no task has taken, because all were out of slots, as those that are left.  `which` may be
   that list itself. */
static pbw_status pbwl__keep_untaken(const pbwl__changing *batch)
{
    pbw__kernel *main = &batch->core->kernel;
    size_t from, to;
    int share;
    main->left_count = 0;
    for (share = 0; share < batch->parts; share++) {
        if (pbwl__batch_rest(batch, share, batch->taken[share], &from, &to) == 0) {
            continue;
        }
        if (!PBW__GROW(main, main, left, main->left_count + to - from)) {
            return PBW_ERROR_MEMORY;
        }
        for (; from < to; from++) {
            main->left[main->left_count++] = batch->which != NULL ? batch->which[from] : (pbw_index)from;
        }
    }
    return PBW_OK;
}

/* Makes cores for the tasks, and enough slots. */
static pbw_status pbwl__batch_room(const pbwl__changing *batch)
{
    pbwl__core *core = batch->core;
    pbw__context *context = core->kernel.context;
    pbw__store *store = &core->store;
    const size_t parts = (size_t)batch->parts, wanted = batch->slots * batch->round_count + 128 * parts;
    size_t have = core->kernel.slots.free_count + store->capacity - store->count, needed, part;
    pbw_status status = PBW_OK;
    for (part = 0; part < core->tasks; part++) {
        have += core->task[part]->kernel.slots.free_count;
    }
    needed = wanted > have ? store->capacity + wanted - have : 0;
    if (!PBWL__CORE_GROW(core, task, parts)) {
        return PBW_ERROR_MEMORY;
    }
    while (core->tasks < parts) {
        pbwl__core *task = (pbwl__core *)pbw__allocate(&context->memory, 1, sizeof(pbwl__core));
        if (task == NULL) {
            return PBW_ERROR_MEMORY;
        }
        memset(task, 0, sizeof(*task));
        task->kernel.context = context;
        task->kernel.dim = core->kernel.dim;
        task->kernel.slots.free_list = PBW_NONE;
        if (pbw__scratch_create(&task->kernel) != PBW_OK) {
            pbwl__core_free_own(context, task);
            pbw__release(&context->memory, task, 1, sizeof(pbwl__core));
            return PBW_ERROR_MEMORY;
        }
        core->task[core->tasks++] = task;
    }
    needed = needed < PBW__SIMPLEX_LIMIT ? needed : PBW__SIMPLEX_LIMIT;
    if (needed > store->capacity) {
        status = pbw__store_reserve(context, store, needed);
        pbw__kernel_attach(&core->kernel);
    }
    return status == PBW_OK && !pbwl__journal_reserve(core) ? PBW_ERROR_MEMORY : status;
}

static pbw_status pbwl__batch_round(pbwl__changing *batch)
{
    pbwl__core *core = batch->core;
    pbw__context *context = core->kernel.context;
    const size_t share = batch->round_count / (size_t)batch->parts, grain = share / 24, least = share / 32768 + 1;
    pbw_status status = pbwl__batch_room(batch);
    int part;
    if (status != PBW_OK) {
        return status;
    }
    batch->grain = grain < PBWL__GROUP ? PBWL__GROUP : grain < 512 ? grain : least < 512 ? 512 : least;
    memset(batch->taken, 0, sizeof(batch->taken));
    pbwl__share_slots(batch);
    for (part = 0; part < batch->parts; part++) {
        pbwl__task_begin(batch, part);
    }
    pbw__for(context, batch->parts, pbwl__batch_task, batch);
    status = pbwl__keep_untaken(batch);
    core->kernel.last = PBW_NONE;
    for (part = 0; part < batch->parts; part++) {
        const pbw_status ended = pbwl__task_end(core, core->task[part]);
        status = status == PBW_OK ? ended : status;
    }
    return status;
}

/* Returns the number of tasks for so many changes, of at least `least` each, 0 or 1 if one thread makes them: always
   with weights, as only one thread changes hidden points. */
static int pbwl__batch_parts(const pbwl__core *core, size_t count, size_t least)
{
    const size_t most = count / PBW__SMALLER(least);
    const size_t threads = (size_t)core->kernel.context->threads;
    const size_t parts = threads < PBW__NOBODY ? threads : PBW__NOBODY;
    return core->kernel.weighted ? 1 : (int)(most < parts ? most : parts);
}

/* Makes the changes of a round by one thread; `which` may be kernel.left, of which none are left then. */
static pbw_status pbwl__batch_alone(pbwl__core *core, pbwl__changing *batch)
{
    const size_t needed = batch->slots * batch->round_count + 64;
    pbw__kernel *kernel = &core->kernel;
    size_t part;
    for (part = 0; part < core->tasks && kernel->slots.free_count < needed; part++) {
        pbwl__move_slots(core, core->task[part], core, needed - kernel->slots.free_count);
    }
    batch->parts = 1;
    core->handled = kernel->left_count = 0;
    pbwl__journal_expect(batch, core, batch->round_count);
    return pbwl__batch_range(batch, core, batch->which, 0, batch->round_count);
}

/* Makes all changes of a batch, or if `again` those in kernel.left, which then has those that are left: none, unless
   they cannot be made, or all but the first round is for another change. */
static pbw_status pbwl__batch_all(pbwl__core *core, pbwl__changing *batch, int again)
{
    pbw__kernel *kernel = &core->kernel;
    pbw_status status = PBW_OK;
    const size_t vertices = core->vertex_count + 1;
    size_t before, rounds = 0;
    batch->core = core;
    batch->stop = 0;
    batch->which = again ? kernel->left : NULL;
    batch->round_count = again ? kernel->left_count : batch->count;
    batch->parts = pbwl__batch_parts(core, batch->round_count, again ? PBWL__LEAST_LEFT : PBWL__LEAST_CHANGES);
    batch->owner = batch->parts > 1 ? (uint8_t *)pbw__allocate(&kernel->context->memory, vertices, 1) : NULL;
    if (batch->owner != NULL) {
        pbw__set_bytes(kernel->context, batch->owner, PBW__NOBODY, vertices);
    } else if (batch->parts > 1) {
        return PBW_ERROR_MEMORY;
    }
    while (batch->parts > 1 && status == PBW_OK) {
        before = batch->round_count;
        status = pbwl__batch_round(batch);
        batch->which = kernel->left;
        batch->round_count = kernel->left_count;
        batch->parts = batch->once || 4 * batch->round_count >= 3 * before ? 1
                     : pbwl__batch_parts(core, batch->round_count, PBWL__LEAST_LEFT);
        rounds++;
    }
    pbw__release(&kernel->context->memory, batch->owner, batch->owner != NULL ? vertices : 0, 1);
    if (batch->once && rounds > 0) {
        return status;
    }
    return status == PBW_OK ? pbwl__batch_alone(core, batch) : status;
}

/* ------------------------------------------------------------------------------------------------------
   >>places       The vertices by their coordinates: a hash table.
   In: a core, coordinates.  Out: the vertex there, if there is one.
   Holds: each vertex that is not removed has an entry.  Removed and moved vertices may have old ones, which a look-up
   passes by.
   ------------------------------------------------------------------------------------------------------ */
PBW__INLINE size_t pbwl__place_slot(const pbwl__core *core, const double *x)
{
    return (size_t)(pbw__hash_doubles(0, x, core->kernel.dim) >> 20) & (core->place_capacity - 1);
}

/* Returns the entry of the table of places that has, or would have, the vertex at x. */
static size_t pbwl__place_find(const pbwl__core *core, const double *x)
{
    const int dim = core->kernel.dim;
    size_t at = pbwl__place_slot(core, x);
    for (; core->place[at] != 0; at = (at + 1) & (core->place_capacity - 1)) {
        const pbw_index v = core->place[at];
        if (pbw__same_place(pbwl__core_record(core, v), x, dim) && core->incident[v] != PBWL__VERTEX_REMOVED) {
            break;
        }
    }
    return at;
}

/* Puts a vertex into an empty entry of the table, by compare-and-swap, as tasks compete.  Returns the entry, or
   PBW_NONE if a vertex is at the same place.  moving (may be NULL): one of those that move may go there, too. */
PBW__INLINE pbw_index pbwl__place_enter(pbwl__core *core, const double *x, pbw_index vertex, const pbw_live *moving)
{
    const int dim = core->kernel.dim;
    size_t at = pbwl__place_slot(core, x);
    pbw_index v = PBW__LOAD(core->place + at);
    while (v != 0 || !PBW__CAS(core->place + at, &v, vertex)) {
        if (v == 0) {
            continue;                                /* a spurious failure */
        }
        if (v != vertex && pbw__same_place(pbwl__core_record(core, v), x, dim)
            && core->incident[v] != PBWL__VERTEX_REMOVED) {
            return PBW_NONE;
        }
        if (v != vertex && moving != NULL) {
            const size_t i = core->link_index[v];
            if (i < moving->leaving_count && moving->leaving[i] == v
                && pbw__same_place(moving->moved + i * (size_t)dim, x, dim)) {
                return PBW_NONE;
            }
        }
        at = (at + 1) & (core->place_capacity - 1);
        v = PBW__LOAD(core->place + at);
    }
    return (pbw_index)at;
}

static pbw_status pbwl__place_fill(void *arg, size_t from, size_t to)
{
    pbwl__core *core = (pbwl__core *)arg;
    size_t placed = 0, v;
    for (v = from + 1; v <= to; v++) {
        const size_t soon = v + 16 <= to ? v + 16 : v;
        PBW__PREFETCH_TO_WRITE(core->place + pbwl__place_slot(core, pbwl__core_record(core, (pbw_index)soon)));
        if (core->incident[v] != PBWL__VERTEX_REMOVED) {
            (void)pbwl__place_enter(core, pbwl__core_record(core, (pbw_index)v), (pbw_index)v, NULL);
            placed++;
        }
    }
    (void)PBW__ADD(&core->placed, placed);
    return PBW_OK;
}

/* Makes room in the table of places for `more` vertices, in a new table if need be. */
static pbw_status pbwl__place_reserve(pbw_live *live, size_t more)
{
    pbwl__core *core = &live->core;
    pbw__context *context = core->kernel.context;
    size_t size = 64;
    pbw_status status;
    if (core->place != NULL && 2 * (core->placed + more) < core->place_capacity) {
        return PBW_OK;
    }
    while (size < 3 * (live->points + more)) {
        size *= 2;
    }
    PBW__RELEASE(&context->memory, core, place);
    core->place_capacity = core->placed = 0;
    core->place = (pbw_index *)pbw__allocate_large(context, size, sizeof(pbw_index));
    if (core->place == NULL) {
        return PBW_ERROR_MEMORY;
    }
    core->place_capacity = size;
    pbw__set_bytes(context, core->place, 0, size * sizeof(pbw_index));
    status = pbw__for_range(context, core->vertex_count, 4096, 0.0, pbwl__place_fill, core);
    if (status != PBW_OK) {
        PBW__RELEASE(&context->memory, core, place);
        core->place = NULL;
        core->place_capacity = core->placed = 0;
    }
    return status;
}

/* Prefetches the entry for x in the table of places or, some steps later, the record of the vertex in it. */
PBW__INLINE void pbwl__place_prefetch(const pbwl__core *core, const double *x, int later)
{
    const size_t at = pbwl__place_slot(core, x);
    if (!later) {
        PBW__PREFETCH(core->place + at);
    } else {
        PBW__PREFETCH(pbwl__core_record(core, PBW__LOAD(core->place + at)));
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>change       A batch of queued changes: the vertices that leave and arrive.
   In: a live triangulation with a queue.  Out: lists of these vertices, along the curve; the numbers of all places,
   as they will be.
   Holds: points at one place have one vertex, that of the largest weight, then of the lowest number.  Writes to
   tables are noted as edits, deleted simplices in the journal: both are undone if something fails.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwl__classes { pbw_live *live; size_t leave, arrive; } pbwl__classes;

/* Marks and counts those in the queue that leave a place, and those that arrive at one. */
static pbw_status pbwl__classify_range(void *arg, size_t from, size_t to)
{
    pbwl__classes *classes = (pbwl__classes *)arg;
    pbw_live *live = classes->live;
    size_t leave = 0, arrive = 0, i;
    for (i = from; i < to; i++) {
        const pbw_index id = live->queue[i];
        const unsigned state = live->state[id] & (PBWL__COMMITTED | PBWL__KEPT | PBWL__QUEUED);
        const int lives = (state & PBWL__COMMITTED) != 0, stays = (state & PBWL__KEPT) != 0;
        const int moves = lives && stays && !pbw__same_place(pbwl__point(live, id),
                                                             pbwl__core_record(&live->core, live->core.vertex[id]),
                                                             live->dim);
        const unsigned leaves = lives && (moves || !stays), arrives = stays && (moves || !lives);
        live->state[id] = (unsigned char)(state | leaves * PBWL__OLD_PLACE | arrives * PBWL__NEW_PLACE);
        leave += leaves;
        arrive += arrives;
        pbwl__prefetch(live, i, to);
    }
    (void)PBW__ADD(&classes->leave, leave);
    (void)PBW__ADD(&classes->arrive, arrive);
    return PBW_OK;
}

static pbw_index *pbwl__entry(pbw_live *live, unsigned table, size_t at)
{
    pbwl__core *core = &live->core;
    return (table == PBWL__EDIT_VERTEX ? core->vertex : table == PBWL__EDIT_TWIN ? core->twin : core->place) + at;
}

PBW__INLINE pbwl__edit pbwl__edit_of(unsigned table, size_t at, pbw_index old)
{
    const pbwl__edit edit = { (pbw_index)table, (pbw_index)at, old };
    return edit;
}

/* Writes to a table of the core and notes the edit.  Returns 0 if memory is short. */
static int pbwl__set(pbw_live *live, unsigned table, size_t at, pbw_index value)
{
    pbw_index *entry = pbwl__entry(live, table, at);
    if (!PBWL__GROW(live, edit, live->edit_count + 1)) {
        return 0;
    }
    live->edit[live->edit_count++] = pbwl__edit_of(table, at, *entry);
    *entry = value;
    return 1;
}

/* Makes room for `more` vertices beside the unused ones. */
static int pbwl__vertex_reserve(pbwl__core *core, size_t more)
{
    const size_t vertices = core->vertex_count + (more > core->unused_count ? more - core->unused_count : 0) + 1;
    const size_t old = core->link_index_capacity;
    const int enough = vertices < PBWL__VERTEX_REMOVED
        && PBWL__GROW_SHARED(core, record, vertices * ((size_t)core->kernel.dim + 1))
        && PBWL__GROW_SHARED(core, name, vertices) && PBWL__GROW_SHARED(core, incident, vertices)
        && PBWL__GROW_SHARED(core, link_index, vertices) && PBWL__GROW_SHARED(core, neighbor, vertices);
    core->kernel.record = core->record;              /* it may have moved even if memory ran short later */
    memset(core->link_index + old, 0, (core->link_index_capacity - old) * sizeof(pbw_index));
    return enough;
}

/* Makes room for a batch that changes `more` places, with so many new vertices.  lookup: places are looked up. */
static pbw_status pbwl__batch_reserve(pbw_live *live, size_t more, size_t new_vertices, int lookup)
{
    pbwl__core *core = &live->core;
    const int enough = pbwl__vertex_reserve(core, new_vertices) && PBWL__CORE_GROW(core, vertex, live->count)
        && PBWL__CORE_GROW(core, twin, live->count) && PBWL__CORE_GROW(core, link_vertex, more + 1)
        && PBWL__CORE_GROW(core, unused, core->unused_count + more)
        && PBWL__CORE_GROW(core, next_hidden, core->hidden_count)
        && PBWL__CORE_GROW(core, next_container, core->hidden_count) && PBWL__GROW(live, head, more + 1)
        && PBWL__GROW(live, leaving, more + 1) && PBWL__GROW(live, arriving, more + 1)
        && PBWL__GROW(live, joining, more + 1);
    return !enough ? PBW_ERROR_MEMORY : lookup ? pbwl__place_reserve(live, more) : PBW_OK;
}

/* Adds a vertex to the list of those with changes, link_vertex, unless it is there.  Returns where it is.  head: the
   first of its numbers, PBW_NONE if it has none yet. */
static size_t pbwl__affect(pbw_live *live, pbw_index v, pbw_index head)
{
    pbwl__core *core = &live->core;
    const size_t before = core->link_vertices, at = pbwl__link_index(core, v);
    if (core->link_vertices != before) {
        live->head[at] = head;
    }
    return at;
}

/* Removes the numbers that leave from those of a place.  Returns 0 if memory is short. */
static int pbwl__sieve(pbw_live *live, size_t at)
{
    const pbw_index *twin = live->core.twin;
    const pbw_index first = live->core.name[live->core.link_vertex[at]];
    pbw_index head = PBW_NONE, last = PBW_NONE, id = first, next;
    do {
        next = twin[id];
        if ((live->state[id] & PBWL__OLD_PLACE) == 0) {
            if (last != PBW_NONE && twin[last] != id && !pbwl__set(live, PBWL__EDIT_TWIN, last, id)) {
                return 0;
            }
            head = head == PBW_NONE ? id : head;
            last = id;
        }
        id = next;
    } while (id != first);
    live->head[at] = head;
    return head == PBW_NONE || twin[last] == head || pbwl__set(live, PBWL__EDIT_TWIN, last, head);
}

/* Makes a vertex for a number at a place; it still has to be inserted. */
static pbw_index pbwl__new_vertex(pbw_live *live, const double *x, pbw_index id)
{
    pbwl__core *core = &live->core;
    const size_t dim = (size_t)live->dim;
    const pbw_index v = core->unused_count > 0 ? core->unused[--core->unused_count] : (pbw_index)++core->vertex_count;
    double *record = core->record + v * (dim + 1);
    memmove(record, x, dim * sizeof(double));
    record[dim] = live->weight[id];
    core->incident[v] = PBWL__VERTEX_PENDING;
    core->name[v] = id;
    core->neighbor[v] = 0;
    return v;
}

/* Adds a number to those of its place.  The place has no vertex only if two numbers arrived there and each found an
   outdated entry of the other one's vertex, which had been in use before.  Returns 0 if memory is short. */
static int pbwl__join(pbw_live *live, pbw_index id)
{
    pbwl__core *core = &live->core;
    const size_t slot = pbwl__place_find(core, pbwl__point(live, id));
    const int none = core->place[slot] == 0;
    const pbw_index v = none ? pbwl__new_vertex(live, pbwl__point(live, id), id) : core->place[slot];
    const size_t at = pbwl__affect(live, v, none ? PBW_NONE : core->name[v]);
    const pbw_index head = live->head[at];
    if (none) {
        core->placed++;
        live->arriving[live->arriving_count++] = v;
    }
    if ((none && !pbwl__set(live, PBWL__EDIT_PLACE, slot, v))
        || !pbwl__set(live, PBWL__EDIT_VERTEX, id, v)
        || !pbwl__set(live, PBWL__EDIT_TWIN, id, head == PBW_NONE ? id : core->twin[head])
        || (head != PBW_NONE && !pbwl__set(live, PBWL__EDIT_TWIN, head, id))) {
        return 0;
    }
    live->head[at] = head == PBW_NONE ? id : head;
    return 1;
}

/* Chooses the number that gives a place its vertex: the largest weight, then the lowest number.  If that is another
   number than before, a new vertex replaces the old one.  Returns 0 if memory is short. */
static int pbwl__elect(pbw_live *live, size_t at)
{
    pbwl__core *core = &live->core;
    const pbw_index v = core->link_vertex[at], head = live->head[at];
    pbw_index best = head, id, other;
    if (head == PBW_NONE) {
        live->leaving[live->leaving_count++] = v;
        return 1;
    }
    for (id = core->twin[head]; id != head; id = core->twin[id]) {
        if (live->weight[id] != live->weight[best] ? live->weight[id] > live->weight[best] : id < best) {
            best = id;
        }
    }
    if (core->incident[v] == PBWL__VERTEX_PENDING) {
        core->name[v] = best;
        core->record[v * ((size_t)live->dim + 1) + (size_t)live->dim] = live->weight[best];
        core->neighbor[v] = 0;
        return 1;
    }
    if (best == core->name[v]) {
        return 1;
    }
    other = pbwl__new_vertex(live, pbwl__core_record(core, v), best);
    live->leaving[live->leaving_count++] = v;
    live->arriving[live->arriving_count++] = other;
    id = head;
    do {
        if (!pbwl__set(live, PBWL__EDIT_VERTEX, id, other)) {
            return 0;
        }
        id = core->twin[id];
    } while (id != head);
    return pbwl__set(live, PBWL__EDIT_PLACE, pbwl__place_find(core, pbwl__core_record(core, v)), other);
}

/* A list that is being sorted along the curve by the points base[list[i] * stride]. */
typedef struct pbwl__curve_sort {
    const double *base;
    size_t stride;
    pbw_index *list, *order;                         /* order: see pbwl__sort */
    pbwl__gathered gathered;
    pbw__vertices vertices;
} pbwl__curve_sort;

static pbw_status pbwl__sort_gather(void *arg, size_t from, size_t to)
{
    const pbwl__curve_sort *sort = (const pbwl__curve_sort *)arg;
    const pbwl__gathered *gathered = &sort->gathered;
    size_t i;
    for (i = from; i < to; i++) {
        PBW__PREFETCH(sort->base + sort->list[i + 16 < to ? i + 16 : i] * sort->stride);
        pbwl__gathered_set(gathered, i, sort->list[i], sort->base + sort->list[i] * sort->stride, 0.0);
    }
    return PBW_OK;
}

static pbw_status pbwl__sort_permute(void *arg, size_t from, size_t to)
{
    const pbwl__curve_sort *sort = (const pbwl__curve_sort *)arg;
    size_t i;
    for (i = from; i < to; i++) {
        sort->list[i] = sort->gathered.list[sort->vertices.id[i + 1]];
        if (sort->order != NULL) {
            sort->order[i] = sort->vertices.id[i + 1];
        }
    }
    return PBW_OK;
}

/* Sorts a list along the curve by the points base[list[i] * stride].  order (may be NULL) gets for each entry its
   index before. */
static pbw_status pbwl__sort(const pbw_live *live, const double *base, size_t stride, pbw_index *list, size_t count,
                             pbw_index *order)
{
    pbw__context *context = live->core.kernel.context;
    const pbw_stage stage = context->stage;
    pbwl__curve_sort sort;
    pbw__input input;
    pbw_status status = PBW_ERROR_MEMORY;
    size_t i;
    for (i = 0; i < count && order != NULL && count < 3; i++) {
        order[i] = (pbw_index)i;
    }
    if (count < 3) {
        return PBW_OK;
    }
    memset(&sort, 0, sizeof(sort));
    sort.base = base;
    sort.stride = stride;
    sort.list = list;
    sort.order = order;
    if (pbwl__gathered_create(context, &sort.gathered, count, live->dim)) {
        sort.gathered.count = count;
        pbwl__gathered_input(&sort.gathered, 0, &input);
        input.bare = 1;
        status = pbw__enter_stage(context, PBW_STAGE_ORDER) ? PBW_CANCELLED
               : pbw__for_range(context, count, PBW__SMALLER(4096), 0.0, pbwl__sort_gather, &sort);
        status = status == PBW_OK ? pbw__order(context, &input, &sort.vertices) : status;
    }
    if (status == PBW_OK) {
        status = pbw__for_range(context, count, PBW__SMALLER(4096), 0.0, pbwl__sort_permute, &sort);
        pbw__vertices_free(context, &sort.vertices);
        status = status != PBW_OK || pbw__enter_stage(context, stage) ? PBW_CANCELLED : PBW_OK;
    }
    pbwl__gathered_free(&context->memory, &sort.gathered);
    return status;
}

/* Lists the numbers of a range of the queue that arrive. */
static size_t pbwl__list_arrivals(void *arg, size_t from, size_t to, size_t at)
{
    const pbw_live *live = (const pbw_live *)arg;
    size_t found = 0, i;
    for (i = from; i < to; i++) {
        if ((live->state[live->queue[i]] & PBWL__NEW_PLACE) != 0) {
            if (at != PBWL__COUNT) {
                live->joining[at + found] = live->queue[i];
            }
            found++;
        }
    }
    return found;
}

/* Lists the numbers that arrive, along the curve, so that their vertices are in this order too. */
static pbw_status pbwl__batch_arrivals(pbw_live *live)
{
    live->joining_count = pbwl__list(live->core.kernel.context, live->queue_count, pbwl__list_arrivals, live);
    return pbwl__sort(live, live->point, (size_t)live->dim, live->joining, live->joining_count, NULL);
}

/* Returns the vertex for the i-th number that arrives: first the unused ones, then new ones. */
PBW__INLINE pbw_index pbwl__arrive_vertex(const pbw_live *live, size_t i)
{
    const size_t unused = live->saved_unused;
    return i < unused ? live->core.unused[unused - 1 - i] : (pbw_index)(live->saved_vertices + 1 + (i - unused));
}

/* Makes a vertex for each number that arrives. */
static pbw_status pbwl__arrive_make(void *arg, size_t from, size_t to)
{
    pbw_live *live = (pbw_live *)arg;
    pbwl__core *core = &live->core;
    const size_t dim = (size_t)live->dim;
    for (; from < to; from++) {
        const size_t soon = from + 16 < to ? from + 16 : from;
        const pbw_index id = live->joining[from], v = pbwl__arrive_vertex(live, from);
        double *record = core->record + v * (dim + 1);
        PBW__PREFETCH(pbwl__point(live, live->joining[soon]));
        PBW__PREFETCH(live->weight + live->joining[soon]);
        memcpy(record, pbwl__point(live, id), dim * sizeof(double));
        record[dim] = live->weight[id];
        core->incident[v] = PBWL__VERTEX_PENDING;
        core->name[v] = id;
        core->neighbor[v] = 0;
        live->arriving[from] = v;
    }
    return PBW_OK;
}

/* Enters the new vertices into the tables.  If a vertex is at its place already, a number gets 0 in `arriving`. */
static pbw_status pbwl__arrive_enter(void *arg, size_t from, size_t to)
{
    pbw_live *live = (pbw_live *)arg;
    pbwl__core *core = &live->core;
    pbwl__edit *edit = live->edit + live->first_edit;
    size_t i;
    for (i = from; i < to; i++) {
        const pbw_index id = live->joining[i], v = live->arriving[i], soon = live->joining[i + 16 < to ? i + 16 : i];
        const pbw_index at = pbwl__place_enter(core, pbwl__core_record(core, v), v, NULL);
        pbwl__place_prefetch(core, pbwl__core_record(core, live->arriving[i + 16 < to ? i + 16 : i]), 0);
        pbwl__place_prefetch(core, pbwl__core_record(core, live->arriving[i + 8 < to ? i + 8 : i]), 1);
        PBW__PREFETCH_TO_WRITE(core->vertex + soon);
        PBW__PREFETCH_TO_WRITE(core->twin + soon);
        if (at == PBW_NONE) {
            live->arriving[i] = 0;
            (void)PBW__ADD(&live->joins, 1);
            continue;
        }
        edit[3 * i] = pbwl__edit_of(PBWL__EDIT_PLACE, at, 0);
        edit[3 * i + 1] = pbwl__edit_of(PBWL__EDIT_VERTEX, id, core->vertex[id]);
        edit[3 * i + 2] = pbwl__edit_of(PBWL__EDIT_TWIN, id, core->twin[id]);
        core->vertex[id] = v;
        core->twin[id] = id;
    }
    return PBW_OK;
}

/* Adds edits that are filled in later; until then there is nothing to undo.  Returns 0 if memory is short. */
static int pbwl__edits(pbw_live *live, size_t count)
{
    if (!PBWL__GROW(live, edit, live->edit_count + count)) {
        return 0;
    }
    if (count > 0) {                                 /* PBW_NONE in all members */
        pbw__set_bytes(live->core.kernel.context, live->edit + live->edit_count, 0xff, count * sizeof(pbwl__edit));
    }
    live->edit_count += count;
    return 1;
}

/* Gives vertices to the numbers that arrive.  Numbers at the place of another vertex join its numbers; `joining` then
   has the vertices that they did not need. */
static pbw_status pbwl__batch_arrive(pbw_live *live)
{
    pbwl__core *core = &live->core;
    pbw__context *context = core->kernel.context;
    const size_t count = live->joining_count, used = count < live->saved_unused ? count : live->saved_unused;
    pbw_status status;
    size_t i;
    live->joining_count = live->joins = 0;
    if (!pbwl__edits(live, 3 * count)) {
        return PBW_ERROR_MEMORY;
    }
    live->first_edit = live->edit_count - 3 * count;
    core->unused_count -= used;
    core->vertex_count += count - used;
    core->placed += count;
    status = pbw__for_range(context, count, PBW__SMALLER(2048), 0.0, pbwl__arrive_make, live);
    status = status == PBW_OK ? pbw__for_range(context, count, PBW__SMALLER(2048), 0.0, pbwl__arrive_enter, live)
                              : status;
    if (status == PBW_OK && live->joins == 0) {
        live->arriving_count = count;
        return PBW_OK;
    }
    for (i = 0; i < count && status == PBW_OK; i++) {
        if (live->arriving[i] == 0) {
            core->incident[pbwl__arrive_vertex(live, i)] = PBWL__VERTEX_REMOVED;
        }
    }
    status = status == PBW_OK && !pbwl__vertex_reserve(core, live->joins) ? PBW_ERROR_MEMORY : status;
    for (i = 0; i < count && status == PBW_OK; i++) {
        if (live->arriving[i] != 0) {
            live->arriving[live->arriving_count++] = live->arriving[i];
        } else if (pbwl__join(live, live->joining[i])) {
            live->joining[live->joining_count++] = pbwl__arrive_vertex(live, i);
        } else {
            status = PBW_ERROR_MEMORY;
        }
    }
    return status;
}

/* Lists the vertices of those in a range of the queue that leave and are alone at their place. */
static size_t pbwl__list_leaving(void *arg, size_t from, size_t to, size_t at)
{
    const pbw_live *live = (const pbw_live *)arg;
    const pbwl__core *core = &live->core;
    size_t found = 0, i;
    for (i = from; i < to; i++) {
        const pbw_index id = live->queue[i], far = live->queue[i + 32 < to ? i + 32 : i];
        const pbw_index near = live->queue[i + 16 < to ? i + 16 : i];
        PBW__PREFETCH(live->state + far);
        PBW__PREFETCH(core->twin + far);
        PBW__PREFETCH(core->vertex + far);
        if ((live->state[near] & PBWL__OLD_PLACE) != 0) {
            PBW__PREFETCH_TO_WRITE(core->link_index + core->vertex[near]);
        }
        if ((live->state[id] & PBWL__OLD_PLACE) != 0 && core->twin[id] == id) {
            if (at != PBWL__COUNT) {
                core->link_vertex[at + found] = core->vertex[id];
                core->link_index[core->vertex[id]] = (pbw_index)(at + found);
                live->head[at + found] = PBW_NONE;
            }
            found++;
        }
    }
    return found;
}

/* Lists the vertices that leave and arrive, and updates the numbers of places.  duplicates: some have more than
   one. */
static pbw_status pbwl__batch_plan(pbw_live *live, int duplicates)
{
    pbwl__core *core = &live->core;
    size_t i, alone, shared = 0;
    pbw_status status = pbwl__batch_arrivals(live);
    if (status != PBW_OK) {
        return status;
    }
    core->link_vertices = alone = pbwl__list(core->kernel.context, live->queue_count, pbwl__list_leaving, live);
    for (i = 0; i < live->queue_count && duplicates; i++) {
        const pbw_index id = live->queue[i];
        if ((live->state[id] & PBWL__OLD_PLACE) != 0 && core->twin[id] != id) {
            (void)pbwl__affect(live, core->vertex[id], PBW_NONE);
        }
    }
    for (i = alone; i < core->link_vertices; i++) {
        if (!pbwl__sieve(live, i)) {
            return PBW_ERROR_MEMORY;
        }
    }
    status = pbwl__batch_arrive(live);
    if (status == PBW_OK && core->link_vertices == alone && live->joins == 0) {      /* all of them leave */
        memcpy(live->leaving, core->link_vertex, alone * sizeof(pbw_index));
        live->leaving_count = alone;
        return PBW_OK;
    }
    for (i = 0; i < core->link_vertices; i++) {
        shared += live->head[i] != PBW_NONE;
    }
    status = status == PBW_OK && !pbwl__vertex_reserve(core, shared) ? PBW_ERROR_MEMORY : status;
    for (i = 0; i < core->link_vertices; i++) {
        if (status == PBW_OK && !pbwl__elect(live, i)) {
            return PBW_ERROR_MEMORY;
        }
    }
    return status;
}

typedef struct pbwl__fitting { const pbw_live *live; const pbw_index *list; int beyond; } pbwl__fitting;

static pbw_status pbwl__fit_range(void *arg, size_t from, size_t to)
{
    pbwl__fitting *fitting = (pbwl__fitting *)arg;
    const pbwl__core *core = &fitting->live->core;
    const int dim = fitting->live->dim;
    const int width = fitting->list != NULL ? dim + 1 : dim;             /* weights stay where points move */
    const double unit = core->grid.inverse_unit;
    int k;
    for (; from < to && !PBW__LOAD(&fitting->beyond); from++) {
        const double *x = fitting->list == NULL ? fitting->live->moved + from * (size_t)dim
                        : pbwl__core_record(core, fitting->list[from]);
        if (fitting->list != NULL) {
            PBW__PREFETCH(pbwl__core_record(core, fitting->list[from + 16 < to ? from + 16 : from]));
        }
        for (k = 0; k < width; k++) {
            const double units = x[k] * (k < dim ? unit : unit * unit);
            if (!(x[k] >= core->low[k] && x[k] <= core->high[k]
                  && (pbw__abs(units) >= 9007199254740992.0 || (double)(int64_t)units == units))) {
                PBW__STORE(&fitting->beyond, 1);
                break;
            }
        }
    }
    return PBW_OK;
}

/* Gives up the grid if a new record is not on it, or outside of the box that it was made for: that of a vertex in
   the list, or if list is NULL of one that moves. */
static pbw_status pbwl__fit_grid(pbw_live *live, const pbw_index *list, size_t count)
{
    pbwl__core *core = &live->core;
    pbwl__fitting fitting = { live, list, 0 };
    pbw_status status = PBW_OK;
    if (core->grid.inverse_unit != 0.0) {
        status = pbw__for_range(core->kernel.context, count, PBW__SMALLER(1024), 0.0, pbwl__fit_range, &fitting);
        if (fitting.beyond) {
            memset(&core->grid, 0, sizeof(core->grid));
            core->kernel.exact_height = 0.0;
        }
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>batch        The vertices that leave and arrive, removed and inserted.
   In: their lists, of >>change.  Out: the core with the changes, or as it was.
   Holds: of those that arrive, each starts its walk from a vertex near it that stays or came before: a neighbour of
   the place that its number left, one of its cell of the table of starts, or the one before it on the curve.
   ------------------------------------------------------------------------------------------------------ */
static pbw_index pbwl__near_leaving(void *arg, pbwl__core *core, size_t i)
{
    (void)core;
    return ((const pbw_live *)arg)->leaving[i];
}

/* Removes the i-th vertex that leaves.  If its number arrives elsewhere, the new vertex gets a neighbour. */
static pbw_status pbwl__change_leaving(void *arg, pbwl__core *core, size_t i, pbw_index near)
{
    const pbw_live *live = (const pbw_live *)arg;
    const pbw_index v = live->leaving[i], other = core->vertex[core->name[v]];
    pbw_status status = pbwl__hold(&core->kernel, v) ? PBW_OK : PBW__DEFERRED;
    (void)near;
    if (status == PBW_OK && core->incident[v] == PBW_NONE) {
        core->incident[v] = PBWL__VERTEX_REMOVED;    /* it was hidden */
        return PBW_OK;
    }
    status = status == PBW_OK ? pbwl__remove_vertex(core, v) : status;
    if (status == PBW_OK && core->start != NULL) {
        pbwl__start_leave(core, v);
    }
    if (status == PBW_OK && other != v && pbwl__hold(&core->kernel, other)
        && core->incident[other] == PBWL__VERTEX_PENDING) {
        core->neighbor[other] = core->link_vertex[core->link_vertices - 1];
    }
    return status;
}

/* Returns a vertex near the i-th that arrives: the last one in its cell, or its neighbour. */
static pbw_index pbwl__near_arriving(void *arg, pbwl__core *core, size_t i)
{
    const pbw_index v = ((const pbw_live *)arg)->arriving[i];
    const double *p = pbwl__core_record(core, v);
    return pbwl__nearer_start(core, core->neighbor[v],
                              core->start != NULL ? PBW__LOAD(core->start + pbwl__start_cell(core, p)) : 0, p);
}

/* Inserts the i-th vertex that arrives, starting from `near` or from the vertex before. */
static pbw_status pbwl__change_arriving(void *arg, pbwl__core *core, size_t i, pbw_index near)
{
    const pbw_live *live = (const pbw_live *)arg;
    const pbw_index v = live->arriving[i];
    const double *p = pbwl__core_record(core, v);
    pbw_status status;
    near = pbwl__nearer_start(core, near, i > 0 ? live->arriving[i - 1] : 0, p);
    if (!pbwl__hold(&core->kernel, v) || (near == 0 && core->kernel.own.owner != NULL)) {
        return PBW__DEFERRED;
    }
    if (core->incident[v] != PBWL__VERTEX_PENDING) { /* see pbwl__batch_seeds */
        return PBW_OK;
    }
    status = pbwl__insert_vertex(core, v,
                                 pbwl__start_near(core, near != 0 ? core->incident[near] : core->kernel.last));
    if (core->start != NULL) {
        PBW__STORE(core->start + pbwl__start_cell(core, p), v);
    }
    return status;
}

/* If those that arrive crowd in few cells of the table of starts, inserts some of them, by one thread, and lets the
   others start from these: tasks that all start from one vertex, which one of them owns, put off most. */
static pbw_status pbwl__batch_seeds(pbw_live *live, pbwl__changing *batch)
{
    pbwl__core *core = &live->core;
    pbw__kernel *kernel = &core->kernel;
    const size_t count = live->arriving_count;
    const int parts = pbwl__batch_parts(core, count, PBWL__LEAST_CHANGES);
    const size_t step = parts > 1 ? count / (64 * (size_t)parts) : 0;
    const double end = batch->end;
    size_t crowded = 0, i;
    pbw_status status;
    if (core->start == NULL || step < 4 || !PBW__GROW(kernel, kernel, left, count / step + 1)) {
        return PBW_OK;
    }
    for (kernel->left_count = i = 0; i < count; i += step) {
        const pbw_index v = live->arriving[i], before = live->arriving[i > 0 ? i - step : 0];
        crowded += pbwl__start_cell(core, pbwl__core_record(core, v))
                == pbwl__start_cell(core, pbwl__core_record(core, before));
        kernel->left[kernel->left_count++] = (pbw_index)i;
    }
    if (4 * crowded < kernel->left_count) {
        return PBW_OK;
    }
    batch->core = core;
    batch->stop = 0;
    batch->which = kernel->left;
    batch->round_count = kernel->left_count;
    batch->end = batch->begin;                       /* these are few: no progress */
    status = pbwl__batch_alone(core, batch);
    batch->end = end;
    for (i = 0; i < count; i++) {
        core->neighbor[live->arriving[i]] = live->arriving[i - i % step];
    }
    return status;
}

/* Carries out a batch; on any status but PBW_OK the caller undoes it.  PBWL__REBUILD: rebuild instead. */
static pbw_status pbwl__batch_run(pbw_live *live, size_t most_effort)
{
    pbwl__core *core = &live->core;
    const double all = (double)(live->leaving_count + live->arriving_count + 1);
    pbwl__changing batch;
    pbw_status status = pbwl__sort(live, core->record, (size_t)live->dim + 1, live->leaving, live->leaving_count,
                                   NULL);
    size_t i;
    for (i = 0; i < live->arriving_count / 2; i++) { /* backwards: the slots freed last are taken first, and near */
        const pbw_index v = live->arriving[i];
        live->arriving[i] = live->arriving[live->arriving_count - 1 - i];
        live->arriving[live->arriving_count - 1 - i] = v;
    }
    status = status == PBW_OK ? pbwl__fit_grid(live, live->arriving, live->arriving_count) : status;
    memset(&batch, 0, sizeof(batch));
    core->effort = 0;
    batch.arg = live;
    batch.most_effort = most_effort;
    batch.count = live->leaving_count;
    batch.near = pbwl__near_leaving;
    batch.change = pbwl__change_leaving;
    batch.end = (double)live->leaving_count / all;
    batch.deleted = live->dim == 3 ? 22 : 6;
    status = status == PBW_OK ? pbwl__batch_all(core, &batch, 0) : status;
    core->next_hidden_count = 0;
    for (i = 0; i < core->hidden_count; i++) {
        if (core->incident[core->hidden[i]] == PBW_NONE) {
            core->next_hidden[core->next_hidden_count] = core->hidden[i];
            core->next_container[core->next_hidden_count++] = core->container[i];
        }
    }
    pbwl__start_table(core, live->arriving_count,
                      pbwl__batch_parts(core, live->arriving_count, PBWL__LEAST_CHANGES) > 1);
    batch.count = live->arriving_count;
    batch.near = pbwl__near_arriving;
    batch.change = pbwl__change_arriving;
    batch.slots = live->dim == 3 ? 7 : 2;            /* on average */
    batch.deleted = live->dim == 3 ? 18 : 4;
    batch.begin = batch.end;
    batch.end = 1.0;
    batch.backwards = 1;
    status = status == PBW_OK ? pbwl__batch_seeds(live, &batch) : status;
    status = status == PBW_OK ? pbwl__batch_all(core, &batch, 0) : status;
    return status == PBW_OK ? pbwl__settle_hidden(core) : status;
}

/* Saves what pbwl__batch_undo needs besides edits and the journal. */
static void pbwl__batch_begin(pbw_live *live)
{
    pbwl__core *core = &live->core;
    core->sorted = 0;
    live->edit_count = 0;
    live->saved_vertices = core->vertex_count;
    live->saved_unused = core->unused_count;
    live->saved_placed = core->placed;
    live->saved_grid = core->grid;
    live->saved_height = core->kernel.exact_height;
}

static void pbwl__batch_undo(pbw_live *live)
{
    pbwl__core *core = &live->core;
    core->grid = live->saved_grid;
    core->kernel.exact_height = live->saved_height;
    while (live->edit_count > 0) {
        const pbwl__edit *edit = live->edit + --live->edit_count;
        if (edit->at != PBW_NONE) {
            *pbwl__entry(live, edit->table, edit->at) = edit->old;
        }
    }
    pbwl__journal_undo(core);
    core->vertex_count = live->saved_vertices;
    while (core->unused_count < live->saved_unused) {
        core->incident[core->unused[core->unused_count++]] = PBWL__VERTEX_REMOVED;
    }
    core->placed = live->saved_placed;
}

/* Makes a batch of changes, all or nothing. */
static pbw_status pbwl__batch(pbw_live *live, size_t leave, size_t arrive, size_t most_effort,
                              pbw_changes *changes)
{
    pbwl__core *core = &live->core;
    const int duplicates = core->vertex_count - core->unused_count != live->points;
    pbw_status status = pbwl__batch_reserve(live, leave + 2 * arrive, arrive, arrive > 0 || duplicates);
    if (status != PBW_OK) {
        return status;
    }
    pbwl__batch_begin(live);
    live->leaving_count = live->arriving_count = 0;
    status = pbwl__batch_plan(live, duplicates);
    status = status == PBW_OK ? pbwl__batch_run(live, most_effort) : status;
    if (status == PBW_OK && changes != NULL) {
        status = pbwl__batch_changes(live, changes);
    }
    if (status != PBW_OK) {
        pbwl__batch_undo(live);
        return status;
    }
    memcpy(core->unused + core->unused_count, live->leaving, live->leaving_count * sizeof(pbw_index));
    core->unused_count += live->leaving_count;
    memcpy(core->unused + core->unused_count, live->joining, live->joining_count * sizeof(pbw_index));
    core->unused_count += live->joining_count;
    pbwl__swap_hidden(core);
    pbwl__journal_clear(core);
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>moves        Points that keep their neighbours, or most of them.
   In: a live triangulation with points that only move.  Out: its core with these in new places, or as it was.

   All at once: the coordinates are exchanged, then >>verify runs.  One by one: a vertex gets its new place if its
   star stays positive; in the plane flips then make it Delaunay.  If a simplex would be inverted, at the hull, and in
   space if its star is not Delaunay, the vertex is removed and inserted.  In between, the core triangulates some old
   and some new places, so no new place may be an old one.  The table of places tells that, if there is one.  Without
   it, one walk per vertex that is inserted again does; a vertex that stays in its star meets no other vertex there.
   ------------------------------------------------------------------------------------------------------ */
/* Exchanges the coordinates of a vertex with others. */
PBW__INLINE void pbwl__exchange(pbwl__core *core, pbw_index v, double *other)
{
    const size_t dim = (size_t)core->kernel.dim;
    double *record = core->record + v * (dim + 1);
    size_t k;
    for (k = 0; k < dim; k++) {
        const double x = record[k];
        record[k] = other[k];
        other[k] = x;
    }
}

/* Exchanges the coordinates of those that move with the other ones; completes even if the call is cancelled. */
static void pbwl__exchange_share(void *arg, int part)
{
    pbw_live *live = (pbw_live *)arg;
    const int parts = pbw__tasks(live->core.kernel.context, live->leaving_count, 2048);
    const size_t dim = (size_t)live->dim, end = pbw__share(live->leaving_count, part + 1, parts);
    size_t i;
    for (i = pbw__share(live->leaving_count, part, parts); i < end; i++) {
        const size_t soon = live->leaving[i + 16 < end ? i + 16 : i];
        PBW__PREFETCH_TO_WRITE(live->core.record + soon * (dim + 1));
        pbwl__exchange(&live->core, live->leaving[i], live->moved + i * dim);
    }
}

static void pbwl__live_exchange(pbw_live *live)
{
    pbw__context *context = live->core.kernel.context;
    pbw__for(context, pbw__tasks(context, live->leaving_count, 2048), pbwl__exchange_share, live);
}

typedef struct pbwl__moving { pbw_live *live; int others; } pbwl__moving;

/* Lists the vertices of a range of the queue that move and are alone at their place; notes whether others change. */
static size_t pbwl__list_moving(void *arg, size_t from, size_t to, size_t at)
{
    pbwl__moving *moving = (pbwl__moving *)arg;
    pbw_live *live = moving->live;
    const pbwl__core *core = &live->core;
    const size_t dim = (size_t)live->dim;
    size_t found = 0, i;
    for (i = from; i < to; i++) {
        const pbw_index id = live->queue[i], soon = live->queue[i + 16 < to ? i + 16 : i];
        const unsigned both = live->state[id] & (PBWL__OLD_PLACE | PBWL__NEW_PLACE);
        PBW__PREFETCH(core->twin + soon);
        PBW__PREFETCH(core->vertex + soon);
        PBW__PREFETCH(pbwl__point(live, soon));
        if (both == (PBWL__OLD_PLACE | PBWL__NEW_PLACE) && core->twin[id] == id) {
            if (at != PBWL__COUNT) {
                core->link_index[core->vertex[id]] = (pbw_index)(at + found);
                memcpy(live->moved + (at + found) * dim, pbwl__point(live, id), dim * sizeof(double));
                live->leaving[at + found] = core->vertex[id];
            }
            found++;
        } else if (both != 0) {
            PBW__STORE(&moving->others, 1);
        }
    }
    return found;
}

/* Lists the vertices that move.  PBWL__REBUILD: there are other changes, or duplicates or hidden points matter. */
static pbw_status pbwl__list_moves(pbw_live *live, size_t count)
{
    pbwl__moving moving = { live, 0 };
    if (live->core.hidden_count > 0) {
        return PBWL__REBUILD;
    }
    if (!PBWL__GROW(live, leaving, count) || !PBWL__GROW(live, moved, count * (size_t)live->dim)) {
        return PBW_ERROR_MEMORY;
    }
    live->leaving_count = pbwl__list(live->core.kernel.context, live->queue_count, pbwl__list_moving, &moving);
    return moving.others ? PBWL__REBUILD : PBW_OK;
}

/* Moves the listed vertices in place, all or nothing.  PBWL__REBUILD: impossible in place. */
static pbw_status pbwl__in_place(pbw_live *live, pbw_changes *changes)
{
    pbwl__core *core = &live->core;
    pbw_status status;
    pbwl__batch_begin(live);
    status = pbwl__fit_grid(live, NULL, live->leaving_count);
    pbwl__live_exchange(live);
    status = status == PBW_OK ? pbwl__verify(core, core->simplex_count / 2 + 64) : status;
    if (status == PBW_OK && changes != NULL) {
        status = pbwl__batch_changes(live, changes);
    }
    if (status != PBW_OK) {
        pbwl__live_exchange(live);
        pbwl__batch_undo(live);
        return status;
    }
    PBW__RELEASE(&core->kernel.context->memory, core, place);        /* outdated */
    core->place = NULL;
    core->place_capacity = core->placed = 0;
    return PBW_OK;
}

/* ---- one by one */
/* Collects the star of v in scratch.cavity, without marks.  PBWL__UNSUITED: it has a ghost.  PBW__DEFERRED: not
   all of its vertices are ours. */
static pbw_status pbwl__shift_star(pbwl__core *core, pbw_index v)
{
    pbw__kernel *kernel = &core->kernel;
    const size_t dim = (size_t)kernel->dim;
    pbw_status status = dim == 3 ? pbwl__collect_star(core, v, 3) : pbwl__collect_star(core, v, 2);
    const size_t count = kernel->scratch.cavity_count;
    size_t i;
    for (i = 0; i < count && status == PBW_OK; i++) {
        status = kernel->corner[4 * (size_t)kernel->scratch.cavity[i] + dim] == PBW__GHOST ? PBWL__UNSUITED : PBW_OK;
    }
    (void)pbw__leave_cavity(kernel, count);
    kernel->scratch.cavity_count = count;
    return status;
}

/* Gives the i-th vertex that moves its new place, or the old one back. */
static void pbwl__shift_exchange(pbw_live *live, size_t i)
{
    pbwl__exchange(&live->core, live->leaving[i], live->moved + live->arriving[i] * (size_t)live->dim);
    live->head[i] ^= 1;
}

/* Gives a vertex its new place if its star stays positive; then flips.  PBWL__UNSUITED: the star does not stay
   positive, or in space is not Delaunay. */
static pbw_status pbwl__shift_in_place(pbw_live *live, pbwl__core *core, size_t at)
{
    pbw__kernel *kernel = &core->kernel;
    const int dim = kernel->dim;
    size_t count = 0, i;
    unsigned k;
    pbw_status status = pbwl__shift_star(core, live->leaving[at]);
    core->effort += kernel->scratch.cavity_count;
    if (status != PBW_OK) {
        return status;
    }
    pbwl__shift_exchange(live, at);
    for (i = 0; i < kernel->scratch.cavity_count && status == PBW_OK; i++) {
        const size_t t = kernel->scratch.cavity[i];
        const unsigned faults = dim == 3 ? pbwl__slot_faults(core, t, 1, 3) : pbwl__slot_faults(core, t, 1, 2);
        if (faults == PBWL__INVERTED || (faults != 0 && dim == 3)) {
            status = PBWL__UNSUITED;
        } else if (faults != 0 && !PBWL__CORE_GROW(core, edge, count + 3)) {
            status = PBW_ERROR_MEMORY;
        }
        for (k = 0; k < 3 && status == PBW_OK && faults != 0; k++) {
            core->edge[count] = (pbw__link)(4 * t + k);
            count += faults >> k & 1;
        }
    }
    if (status == PBWL__UNSUITED) {
        pbwl__shift_exchange(live, at);
    }
    return status != PBW_OK || count == 0 ? status : pbwl__flip_all(core, count, live->core.saved_simplices);
}

/* Walks to where v, which is in no simplex, is to be inserted.  PBWL__REBUILD: another vertex is there; it is a
   corner of each simplex that contains the place. */
static pbw_status pbwl__shift_container(pbwl__core *core, pbw_index v, pbw_index *start)
{
    const pbw_status status = pbwl__locate_vertex(core, start, v);
    const pbw_index *corner = core->kernel.corner + 4 * (size_t)*start;
    const double *x = pbwl__core_record(core, v);
    const int dim = core->kernel.dim;
    int k, taken = 0;
    for (k = 0; k <= dim && status == PBW_OK; k++) {
        taken |= corner[k] != PBW__GHOST && pbw__same_place(pbwl__core_record(core, corner[k]), x, dim);
    }
    return taken ? PBWL__REBUILD : status;
}

/* Removes the i-th vertex and inserts it at its new place.  PBW__DEFERRED is possible after the removal, too: the
   next call then inserts it. */
static pbw_status pbwl__change_again(void *arg, pbwl__core *core, size_t i, pbw_index near)
{
    pbw_live *live = (pbw_live *)arg;
    const pbw_index v = live->leaving[i];
    pbw_index start;
    pbw_status status;
    (void)near;
    if (!pbwl__hold(&core->kernel, v)) {
        return PBW__DEFERRED;
    }
    if (core->incident[v] != PBWL__VERTEX_REMOVED) {
        status = pbwl__remove_vertex(core, v);
        if (status != PBW_OK) {
            return status;
        }
        core->neighbor[v] = core->link_vertex[core->link_vertices - 1];
        core->reinserted++;
        pbwl__shift_exchange(live, i);
    }
    near = pbwl__nearer_start(core, core->neighbor[v], 0, pbwl__core_record(core, v));
    if (near == 0 && core->kernel.own.owner != NULL) {
        return PBW__DEFERRED;
    }
    start = pbwl__start_near(core, near != 0 ? core->incident[near] : core->kernel.last);
    status = core->place == NULL ? pbwl__shift_container(core, v, &start) : PBW_OK;
    return status == PBW_OK ? pbwl__insert_vertex(core, v, start) : status;
}

/* Moves the i-th vertex.  In the plane, PBW__DEFERRED if it cannot stay in its star: flips may be due around it. */
static pbw_status pbwl__change_place(void *arg, pbwl__core *core, size_t i, pbw_index near)
{
    pbw_live *live = (pbw_live *)arg;
    const pbw_index v = live->leaving[i];
    pbw_status status = pbwl__hold(&core->kernel, v) ? PBW_OK : PBW__DEFERRED;
    if (status == PBW_OK && core->incident[v] != PBWL__VERTEX_REMOVED) {
        status = pbwl__shift_in_place(live, core, i);
    } else if (status == PBW_OK) {
        status = PBWL__UNSUITED;
    }
    return status != PBWL__UNSUITED ? status
         : live->dim == 2 ? PBW__DEFERRED : pbwl__change_again(live, core, i, near);
}

/* Enters a range of the new places into the table.  PBWL__REBUILD: a vertex is or will be at one of them. */
static pbw_status pbwl__shift_enter(void *arg, size_t from, size_t to)
{
    pbw_live *live = (pbw_live *)arg;
    pbwl__core *core = &live->core;
    const size_t dim = (size_t)live->dim;
    size_t i;
    for (i = from; i < to; i++) {
        const double *x = live->moved + i * dim;
        pbwl__place_prefetch(core, live->moved + (i + 16 < to ? i + 16 : i) * dim, 0);
        pbwl__place_prefetch(core, live->moved + (i + 8 < to ? i + 8 : i) * dim, 1);
        live->edit[i] = pbwl__edit_of(PBWL__EDIT_PLACE, pbwl__place_enter(core, x, live->leaving[i], live), 0);
        if (live->edit[i].at == PBW_NONE) {
            return PBWL__REBUILD;
        }
    }
    return PBW_OK;
}

/* Enters all new places into the table, if there is one.  PBWL__REBUILD: a vertex is at one, or two go there. */
static pbw_status pbwl__shift_places(pbw_live *live)
{
    pbwl__core *core = &live->core;
    pbw__context *context = core->kernel.context;
    const size_t count = live->leaving_count;
    pbw_status status = pbwl__fit_grid(live, NULL, count);
    if (status != PBW_OK || core->place == NULL) {
        return status;
    }
    if (!pbwl__edits(live, count)) {
        return PBW_ERROR_MEMORY;
    }
    core->placed += count;
    return pbw__for_range(context, count, PBW__SMALLER(2048), 0.0, pbwl__shift_enter, live);
}

/* Moves vertices one by one along the curve. */
static pbw_status pbwl__shift_all(pbw_live *live, size_t most_effort)
{
    pbwl__core *core = &live->core;
    const size_t count = live->leaving_count;
    pbwl__changing batch;
    pbw_status status = pbwl__sort(live, core->record, (size_t)live->dim + 1, live->leaving, count, live->arriving);
    memset(&batch, 0, sizeof(batch));
    batch.arg = live;
    batch.near = pbwl__near_leaving;
    batch.change = pbwl__change_place;
    batch.count = count;
    batch.slots = live->dim == 3 ? 2 : 0;            /* a removal frees slots, perhaps of another task */
    batch.once = live->dim == 2;
    batch.deleted = live->dim == 3 ? 22 : 1;
    batch.most_effort = most_effort;
    batch.end = 0.9;
    core->effort = core->reinserted = core->untested_count = 0;
    status = status == PBW_OK ? pbwl__batch_all(core, &batch, 0) : status;
    if (status == PBW_OK && live->dim == 2) {
        status = PBWL__CORE_GROW(core, edge, core->untested_count) ? PBW_OK : PBW_ERROR_MEMORY;
        if (status == PBW_OK && core->untested_count > 0) {
            memcpy(core->edge, core->untested, core->untested_count * sizeof(pbw__link));
            status = pbwl__flip_all(core, core->untested_count, core->saved_simplices);
        }
        batch.change = pbwl__change_again;
        batch.once = 0;
        batch.begin = 0.9;
        batch.end = 1.0;
        status = status == PBW_OK ? pbwl__batch_all(core, &batch, 1) : status;
    }
    return status;
}

/* Moves a few of the vertices one by one, all or nothing.  listed: the status of listing them, PBWL__UNSUITED if they
   are still to be listed.  PBWL__REBUILD: impossible one by one. */
static pbw_status pbwl__shift(pbw_live *live, pbw_status listed, size_t count, size_t most_effort,
                              pbw_changes *changes, pbw_way *way)
{
    pbwl__core *core = &live->core;
    const int placed = core->place != NULL;
    size_t i;
    pbw_status status = core->kernel.weighted ? PBWL__REBUILD
                      : listed == PBWL__UNSUITED ? pbwl__list_moves(live, count) : listed;
    status = status == PBW_OK ? pbwl__batch_reserve(live, count, 0, placed) : status;
    if (status != PBW_OK) {
        return status;
    }
    pbwl__batch_begin(live);
    memset(live->head, 0, count * sizeof(pbw_index));
    core->reinserted = 0;
    status = pbwl__shift_places(live);
    status = status == PBW_OK ? pbwl__shift_all(live, most_effort) : status;
    *way = core->reinserted > 0 ? PBW_WAY_BATCH : pbwl__journal_any(core) ? PBW_WAY_FLIPS : PBW_WAY_NOTHING;
    if (status == PBW_OK && changes != NULL) {
        status = pbwl__batch_changes(live, changes);
    }
    if (status != PBW_OK) {
        for (i = 0; i < count; i++) {
            if (live->head[i] != 0) {
                pbwl__shift_exchange(live, i);
            }
        }
        pbwl__batch_undo(live);
        return status;
    }
    pbwl__journal_clear(core);
    return PBW_OK;
}

/* ------------------------------------------------------------------------------------------------------
   >>commit       Carries out queued changes.
   In: a live triangulation with a queue.  Out: its core with the changes, by the fastest way.
   Holds: all ways lead to one triangulation; after a failure the core and the queue are as before.  The first commit
   is that of pbw_live_create, with all points of a mesh.
   ------------------------------------------------------------------------------------------------------ */
/* Replaces the core by another one. */
static void pbwl__replace(pbw_live *live, pbw__context *context, const pbwl__core *core)
{
    pbwl__core_free(context, &live->core);
    live->core = *core;
    if (core->kernel.journal != NULL) {
        live->core.kernel.store = &live->core.store;
        live->core.kernel.grid = &live->core.grid;
        live->core.kernel.journal = &live->core;
    }
}

typedef struct pbwl__gathering { const pbw_live *live; pbwl__gathered *gathered; } pbwl__gathering;

/* Gathers the points of a range of numbers that stay. */
static size_t pbwl__gather_kept(void *arg, size_t from, size_t to, size_t at)
{
    const pbwl__gathering *gathering = (const pbwl__gathering *)arg;
    const pbw_live *live = gathering->live;
    size_t found = 0, i;
    for (i = from; i < to; i++) {
        if ((live->state[i] & PBWL__KEPT) != 0) {
            if (at != PBWL__COUNT) {
                pbwl__gathered_set(gathering->gathered, at + found, (pbw_index)i, pbwl__point(live, i),
                                   live->weight[i]);
            }
            found++;
        }
    }
    return found;
}

static pbw_status pbwl__count_kept(void *arg, size_t from, size_t to)
{
    const pbwl__gathering *gathering = (const pbwl__gathering *)arg;
    (void)PBW__ADD(&gathering->gathered->count, pbwl__gather_kept(arg, from, to, PBWL__COUNT));
    return PBW_OK;
}

/* Triangulates the points that stay into another core, which replaces this one. */
static pbw_status pbwl__rebuild(pbw_live *live, pbw__context *context, pbw_changes *changes)
{
    pbwl__gathered gathered;
    pbwl__core core;
    pbwl__gathering gathering = { live, &gathered };
    pbw_status status;
    memset(&core, 0, sizeof(core));
    core.kernel.context = context;
    memset(&gathered, 0, sizeof(gathered));
    gathered.points = live->point;
    gathered.weights = live->weight;
    gathered.dim = (size_t)live->dim;
    status = pbw__for_range(context, live->count, 16384, 0.0, pbwl__count_kept, &gathering);
    if (status == PBW_OK && gathered.count < live->count) {
        status = pbwl__gathered_create(context, &gathered, live->count, live->dim) ? PBW_OK : PBW_ERROR_MEMORY;
        gathered.count = status == PBW_OK ? pbwl__list(context, live->count, pbwl__gather_kept, &gathering) : 0;
    }
    if (status == PBW_OK) {
        status = pbwl__core_build(context, &gathered, live->weighted, live->count, &core);
    }
    pbwl__gathered_free(&context->memory, &gathered);
    if ((status == PBW_OK || status == PBW_DEGENERATE) && changes != NULL) {
        const pbw_status listed = pbwl__rebuild_changes(live, &core, changes);
        status = listed != PBW_OK ? listed : status;
    }
    if (status == PBW_OK || status == PBW_DEGENERATE) {
        pbwl__replace(live, context, &core);
    } else {
        pbwl__core_free(context, &core);
    }
    return status;
}

/* Settles a range of the queue, and lists the numbers that are free from now on. */
static size_t pbwl__settle_range(void *arg, size_t from, size_t to, size_t at)
{
    pbw_live *live = (pbw_live *)arg;
    const size_t dim = (size_t)live->dim;
    size_t points = 0, found = 0, i;
    for (i = from; i < to; i++) {
        const pbw_index id = live->queue[i];
        const int lived = (live->state[id] & PBWL__COMMITTED) != 0, stays = (live->state[id] & PBWL__KEPT) != 0;
        if (at != PBWL__COUNT) {
            points += (size_t)stays - (size_t)lived;
            live->state[id] = stays ? PBWL__KEPT | PBWL__COMMITTED : 0;
            if (!stays) {
                live->spare[live->spare_count + at + found] = id;
                memset(live->point + id * dim, 0, dim * sizeof(double));
                live->weight[id] = 0.0;
            }
        }
        found += (size_t)!stays;
    }
    (void)PBW__ADD(&live->points, points);           /* wraps around */
    return found;
}

/* Empties the queue after its changes have been carried out. */
static void pbwl__settle(pbw_live *live)
{
    live->spare_count += pbwl__list(live->core.kernel.context, live->queue_count, pbwl__settle_range, live);
    live->queue_count = 0;
    live->numbers = live->count;
    live->weighted_before = live->weighted;
}

/* What changes cost, in points of a rebuild.  Measured with bench/live.cpp, these limits at 1e9 and at -1, on one
   thread, 5 to 20 % of 200,000 uniform points: in the plane remove 0.82 us, insert 1.05, move 0.53, rebuild 0.134 us
   per point; in space 5.3, 3.0, 6.5 and 0.8.  A rebuild is chosen if changes cost more than PBWL__REBUILD_AT
   rebuilds.  Verifying all costs 0.21 rebuilds in the plane and 0.14 in space, less if it soon fails: no more than
   moving one point in ten. */
#ifndef PBWL__REBUILD_AT
#define PBWL__REBUILD_AT(dim) 1.0
#endif
#ifndef PBWL__VERIFY_AT
#define PBWL__VERIFY_AT(dim) 0.1
#endif
#define PBWL__EFFORT(dim) ((dim) == 3 ? 128 : 32)    /* so many tests for an apex take as long as a point of a
                                                        rebuild */

static double pbwl__change_cost(int dim, size_t leave, size_t arrive, int near)
{
    return near ? (dim == 3 ? 8.0 : 4.0) * (double)leave
         : 6.0 * (double)leave + (dim == 3 ? 3.8 : 8.0) * (double)arrive;
}

/* Returns 1 if most of a sample of the points that move do so by less than four edges.  Others are better removed and
   inserted, with walks that start near their new places. */
static int pbwl__near(const pbw_live *live)
{
    const pbwl__core *core = &live->core;
    const size_t dim = (size_t)live->dim, step = live->queue_count / 64 + 1;
    size_t i, k, seen = 0, far = 0;
    for (i = 0; i < live->queue_count; i += step) {
        const pbw_index id = live->queue[i];
        const int both = (live->state[id] & PBWL__COMMITTED) != 0 && (live->state[id] & PBWL__KEPT) != 0;
        const pbw_index v = both ? core->vertex[id] : PBW__GHOST;              /* others may have no vertex yet */
        if (both && core->twin[id] == id && core->incident[v] < PBWL__VERTEX_REMOVED
            && !pbw__same_place(pbwl__point(live, id), pbwl__core_record(core, v), live->dim)) {
            const pbw_index *corner = core->kernel.corner + 4 * (size_t)core->incident[v];
            const double *x = pbwl__core_record(core, v), *y = pbwl__point(live, id);
            const double *z = pbwl__core_record(core, corner[corner[0] == v]);
            double way = 0, edge = 0;
            for (k = 0; k < dim; k++) {
                way += (y[k] - x[k]) * (y[k] - x[k]);
                edge += (z[k] - x[k]) * (z[k] - x[k]);
            }
            far += !(way <= 16 * edge);
            seen++;
        }
    }
    return 2 * far <= seen;
}

/* Lists the vertices of a range.  Counts those that move, and those in the queue that live and stay. */
PBW__INLINE void pbwl__list_all_of(pbwl__classes *classes, size_t from, size_t to, int dim)
{
    pbw_live *live = classes->live;
    const pbw_index *name = live->core.name + 1;
    const size_t size = (size_t)dim, width = size + 1;
    size_t moves = 0, remain = 0, i;
    for (i = from; i < to; i++) {
        const pbw_index id = name[i], soon = name[i + PBW__SOON < to ? i + PBW__SOON : i];
        double *x = live->moved + i * size;
        PBW__PREFETCH(live->point + soon * size);
        PBW__PREFETCH(live->state + soon);
        memcpy(x, live->point + id * size, size * sizeof(double));
        moves += !pbw__same_place(x, live->core.record + (i + 1) * width, dim);
        remain += live->state[id] == (PBWL__COMMITTED | PBWL__KEPT | PBWL__QUEUED);
        live->leaving[i] = (pbw_index)(i + 1);
    }
    (void)PBW__ADD(&classes->leave, moves);
    (void)PBW__ADD(&classes->arrive, remain);
}

static pbw_status pbwl__list_all_range(void *arg, size_t from, size_t to)
{
    pbwl__classes *classes = (pbwl__classes *)arg;
    PBW__BY_DIM(classes->live->dim, pbwl__list_all_of, classes, from, to);
    return PBW_OK;
}

/* Lists all vertices in the order of their records, not of the queue, if all points are queued only to move and
   enough of them do.  PBWL__REBUILD if not. */
static pbw_status pbwl__list_all(pbw_live *live)
{
    const pbwl__core *core = &live->core;
    const size_t count = core->vertex_count;
    pbwl__classes classes = { live, 0, 0 };
    pbw_status status;
    if (live->queue_count != count || live->points != count || core->unused_count > 0 || core->hidden_count > 0
        || core->simplex_count == 0 || !pbwl__near(live)) {
        return PBWL__REBUILD;
    }
    if (!PBWL__GROW(live, leaving, count) || !PBWL__GROW(live, moved, count * (size_t)live->dim)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbw__for_range(core->kernel.context, count, 8192, 0.0, pbwl__list_all_range, &classes);
    live->leaving_count = count;
    return status != PBW_OK ? status
         : classes.arrive < count || classes.leave == 0
           || (double)classes.leave < PBWL__VERIFY_AT(live->dim) * (double)count ? PBWL__REBUILD : PBW_OK;
}

/* Tries to move in place.  listed: the status of listing those that move. */
static pbw_status pbwl__try_moves(pbw_live *live, pbw_status listed, pbw_changes *changes, pbw_way *way)
{
    const pbw_status status = listed != PBW_OK ? listed
                            : pbw__enter_stage(live->core.kernel.context, PBW_STAGE_WORK) ? PBW_CANCELLED
                            : pbwl__in_place(live, changes);
    if (status == PBW_OK) {
        *way = pbwl__journal_any(&live->core) ? PBW_WAY_FLIPS : PBW_WAY_NOTHING;
        pbwl__journal_clear(&live->core);
    } else if (status == PBWL__REBUILD) {
        pbwl__changes_release(&live->core.kernel.context->memory, changes);
    }
    return status;
}

/* Chooses a way and carries out the changes.  in_place: 0 if moving in place is known to fail. */
static pbw_status pbwl__choose(pbw_live *live, pbw__context *context, int in_place, pbw_changes *changes,
                               pbw_way *way)
{
    const double points = (double)live->points;
    const size_t most = PBWL__EFFORT(live->dim) * (live->points + 100);
    pbwl__classes classes = { live, 0, 0 };
    size_t leave, arrive;
    int near;
    pbw_status listed = PBWL__UNSUITED;
    pbw_status status = pbw__for_range(context, live->queue_count, PBW__SMALLER(2048), 0.0, pbwl__classify_range,
                                       &classes);
    if (status != PBW_OK) {
        return status;
    }
    status = PBWL__REBUILD;
    leave = classes.leave;
    arrive = classes.arrive;
    if (leave + arrive == 0) {
        return live->core.simplex_count > 0 ? PBW_OK : PBW_DEGENERATE;
    }
    near = live->core.simplex_count > 0 && leave == arrive && pbwl__near(live);
    if (near && in_place && (double)leave >= PBWL__VERIFY_AT(live->dim) * points) {
        listed = pbwl__list_moves(live, leave);
        status = pbwl__try_moves(live, listed, changes, way);
    }
    if (status == PBWL__REBUILD && live->core.simplex_count > 0 && live->weighted == live->core.kernel.weighted
        && pbwl__change_cost(live->dim, leave, arrive, near && !live->weighted)
           <= PBWL__REBUILD_AT(live->dim) * points) {
        if (pbw__enter_stage(context, PBW_STAGE_WORK)) {
            return PBW_CANCELLED;
        }
        status = !near ? PBWL__REBUILD : pbwl__shift(live, listed, leave, most, changes, way);
        if (status == PBWL__REBUILD) {
            pbwl__changes_release(&context->memory, changes);
            status = pbwl__batch(live, leave, arrive, most, changes);
            *way = PBW_WAY_BATCH;
        }
    }
    if (status == PBWL__REBUILD) {
        pbwl__changes_release(&context->memory, changes);
        status = pbwl__rebuild(live, context, changes);
        *way = PBW_WAY_REBUILD;
    }
    return status;
}

static pbw_status pbwl__go(pbw_live *live, pbw__context *context, pbw_changes *changes)
{
    pbw_way way = PBW_WAY_NOTHING;
    const pbw_status listed = pbwl__list_all(live);
    pbw_status status = listed == PBWL__REBUILD ? PBWL__REBUILD : pbwl__try_moves(live, listed, changes, &way);
    status = status == PBWL__REBUILD ? pbwl__choose(live, context, listed == PBWL__REBUILD, changes, &way) : status;
    if (changes != NULL) {
        changes->way = way;
    }
    return status;
}

/* Queues the points of a mesh that exist; counts the absent ones, and those that are not finite. */
typedef struct pbwl__loading { pbw_live *live; const pbw_mesh *mesh; size_t absent, wild; } pbwl__loading;

static pbw_status pbwl__load_range(void *arg, size_t from, size_t to)
{
    pbwl__loading *loading = (pbwl__loading *)arg;
    pbw_live *live = loading->live;
    const pbw_mesh *mesh = loading->mesh;
    const size_t dim = (size_t)live->dim;
    size_t absent = 0, wild = 0, i, k;
    for (i = from; i < to; i++) {
        const int there = mesh->canonical[i] != PBW_NONE;
        for (k = 0; k < dim; k++) {
            live->point[i * dim + k] = there ? mesh->points[i * dim + k] + 0.0 : 0.0;        /* no -0.0 */
        }
        live->weight[i] = there && mesh->weights != NULL ? mesh->weights[i] + 0.0 : 0.0;
        live->state[i] = there ? PBWL__KEPT | PBWL__QUEUED : 0;
        live->queue[i] = (pbw_index)i;
        absent += !there;
        wild += !pbwl__all_finite(live->point + i * dim, dim) || !pbwl__all_finite(live->weight + i, 1);
    }
    (void)PBW__ADD(&loading->absent, absent);
    (void)PBW__ADD(&loading->wild, wild);
    return PBW_OK;
}

/* Queues all points of a mesh; room is reserved. */
static pbw_status pbwl__load(pbw_live *live, pbw__context *context, const pbw_mesh *mesh)
{
    pbwl__loading loading = { live, mesh, 0, 0 };
    pbw_status status = pbw__for_range(context, mesh->point_count, 16384, 0.0, pbwl__load_range, &loading);
    size_t i;
    if (status != PBW_OK || loading.wild > 0) {
        return status != PBW_OK ? status : PBW_ERROR_NOT_FINITE;
    }
    live->count = live->queue_count = mesh->point_count;
    if (loading.absent > 0) {
        live->queue_count = 0;
        for (i = live->count; i-- > 0; ) {
            if (live->state[i] == 0) {
                live->spare[live->spare_count++] = (pbw_index)i;
            } else {
                live->queue[live->queue_count++] = (pbw_index)i;
            }
        }
    }
    return PBW_OK;
}

/* Carries out the queue.  If mesh is not NULL, first queues its points. */
static pbw_status pbwl__run(pbw_live *live, const pbw_mesh *mesh, pbw_changes *changes)
{
    pbw__context context;
    pbw_status status;
    pbw__fp fp = pbw__fp_enter();
    pbwl__context_start(live, &context, mesh != NULL ? mesh->point_count
                       : live->queue_count > live->count / 16 ? live->count        /* a change is worth 16 points */
                       : 16 * live->queue_count);
    context.memory = live->memory;
    live->core.kernel.context = &context;
    status = !pbw__fp_is_exact() ? PBW_ERROR_FP_MODE : mesh != NULL ? pbwl__load(live, &context, mesh) : PBW_OK;
    status = status == PBW_OK ? pbwl__go(live, &context, changes) : status;
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        pbwl__changes_release(&context.memory, changes);
    } else {
        pbwl__settle(live);
    }
    pbw__team_stop(&context);
    if (changes != NULL && changes->memory != NULL) {        /* the caller's from here on */
        const pbwl__owned_changes *owned = (const pbwl__owned_changes *)changes->memory;
        context.memory.used -= sizeof(*owned) + (owned->deleted + owned->made + owned->points) * sizeof(pbw_index);
    }
    live->core.kernel.context = NULL;
    live->memory = context.memory;
    pbw__fp_leave(fp);
    return status;
}

PBWDEF pbw_status pbw_live_commit(pbw_live *live, pbw_changes *changes)
{
    if (changes != NULL) {
        memset(changes, 0, sizeof(*changes));
    }
    return live == NULL ? PBW_ERROR_ARGUMENT : pbwl__run(live, NULL, changes);
}

PBWDEF void pbw_live_free(pbw_live *live)
{
    if (live != NULL) {
        pbw__context context;
        pbw_memory *memory = &context.memory;
        memset(&context, 0, sizeof(context));
        pbwl__team_stop(live);
        context.memory = live->memory;
        pbwl__core_free(&context, &live->core);
        PBW__RELEASE(memory, live, point);
        PBW__RELEASE(memory, live, weight);
        PBW__RELEASE(memory, live, state);
        PBW__RELEASE(memory, live, spare);
        PBW__RELEASE(memory, live, queue);
        PBW__RELEASE(memory, live, edit);
        PBW__RELEASE(memory, live, head);
        PBW__RELEASE(memory, live, leaving);
        PBW__RELEASE(memory, live, arriving);
        PBW__RELEASE(memory, live, joining);
        PBW__RELEASE(memory, live, moved);
        pbw__release(memory, live, 1, sizeof(*live));
    }
}

PBWDEF pbw_status pbw_live_create(const pbw_mesh *mesh, const pbw_options *options, pbw_live **result)
{
    pbw_options defaults;
    pbw_memory memory;
    pbw_live *live;
    pbw_status status;
    memset(&defaults, 0, sizeof(defaults));
    options = options != NULL ? options : &defaults;
    if (result == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    *result = NULL;
    if (!pbw__has_arrays(mesh, 0) || options->threads < 0 || options->threads > 256 || options->flags != 0
        || options->stride != 0 || options->weight_stride != 0 || options->backend != NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    pbw_memory_start(&memory, options);
    live = (pbw_live *)pbw__allocate(&memory, 1, sizeof(*live));
    if (live == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(live, 0, sizeof(*live));
    live->memory = memory;
    live->options = *options;
    live->options.trace = NULL;
    live->options.message = NULL;
    live->dim = mesh->dim;
    live->weighted = mesh->weights != NULL;
    status = pbwl__reserve(live, mesh->point_count, mesh->point_count);
    status = status == PBW_OK ? pbwl__run(live, mesh, NULL) : status;
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        pbw_live_free(live);
        return status;
    }
    *result = live;
    return status;
}
/* ------------------------------------------------------------------------------------------------------
   >>view         The arrays of a live triangulation.
   In: a core.  Out: the mesh that pbw_triangulate makes of the points that live.
   The vertices are sorted along the curve as for a build, which gives their ranks.  The corners are copied as ranks;
   from there on >>number and >>output work as after a build, but write to new arrays, as the core keeps its own.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwl__viewing {
    const pbw_live *live;
    pbw_mesh *mesh;
    size_t duplicates;
    int sorted;                                      /* ranks are vertices, and nothing was sorted */
    const pbw_index *list;                           /* per entry of the sort's input: its vertex; NULL: all */
    pbw_index *id;                                   /* per rank */
    pbw_index *rank;                                 /* per vertex */
    pbw_index *corner;                               /* per slot: the ranks of the corners */
} pbwl__viewing;

/* ---- points: those in the queue have other coordinates than their vertices */
PBW__INLINE void pbwl__view_points_of(pbwl__viewing *viewing, size_t from, size_t to, int dims)
{
    const pbw_live *live = viewing->live;
    const pbwl__core *core = &live->core;
    const size_t dim = (size_t)dims;
    const pbw_mesh *mesh = viewing->mesh;
    double *points = (double *)(uintptr_t)mesh->points, *weights = (double *)(uintptr_t)mesh->weights;
    pbw_index *canonical = (pbw_index *)(uintptr_t)mesh->canonical;
    const int settled = live->queue_count == 0 && core->twin != NULL;
    size_t duplicates = 0, i;
    for (i = from; i < to; i++) {
        const int lives = (live->state[i] & PBWL__COMMITTED) != 0, single = settled && lives && core->twin[i] == i;
        const pbw_index v = lives && !single ? core->vertex[i] : PBW__GHOST;
        if (lives) {
            const double *place = single ? live->point + i * dim : core->record + v * (dim + 1);
            memcpy(points + i * dim, place, dim * sizeof(double));
        } else {
            memset(points + i * dim, 0, dim * sizeof(double));
        }
        canonical[i] = single ? (pbw_index)i : lives ? core->name[v] : PBW_NONE;
        duplicates += lives && canonical[i] != i;
        if (weights != NULL) {
            weights[i] = lives ? live->weight[i] : 0.0;
        }
    }
    (void)PBW__ADD(&viewing->duplicates, duplicates);
}

static pbw_status pbwl__view_points(void *arg, size_t from, size_t to)
{
    pbwl__viewing *viewing = (pbwl__viewing *)arg;
    PBW__BY_DIM(viewing->live->dim, pbwl__view_points_of, viewing, from, to);
    return PBW_OK;
}

/* Makes the points, weights and canonical of a view. */
static pbw_status pbwl__view_begin(pbwl__viewing *viewing, pbw__context *context)
{
    const pbw_live *live = viewing->live;
    const size_t numbers = live->numbers, entries = numbers * (size_t)live->dim;
    pbw_mesh *mesh = viewing->mesh;
    const size_t weights = live->weighted_before ? numbers : 0;
    pbw__owned *owned = (pbw__owned *)mesh->memory;
    double *points = (double *)pbw__allocate(&context->memory, entries, sizeof(double));
    pbw_index *canonical = (pbw_index *)pbw__allocate(&context->memory, numbers, sizeof(pbw_index));
    double *weight = weights > 0 ? (double *)pbw__allocate(&context->memory, weights, sizeof(double)) : NULL;
    const pbw__block block[3] = { pbw__block_of(points, 0, entries * sizeof(double)),
                                  pbw__block_of(canonical, 0, numbers * sizeof(pbw_index)),
                                  pbw__block_of(weight, 0, weights * sizeof(double)) };
    pbw_status status;
    pbw__populate(context, block, 3);
    mesh->points = points;
    mesh->canonical = canonical;
    mesh->weights = weight;
    owned->points = entries;
    owned->weights = owned->canonical = numbers;
    if (mesh->points == NULL || mesh->canonical == NULL || (mesh->weights == NULL && live->weighted_before)) {
        return PBW_ERROR_MEMORY;
    }
    status = pbw__for_range(context, numbers, 16384, 0.0, pbwl__view_points, viewing);
    mesh->duplicate_count = viewing->duplicates;
    return status;
}

/* Gathers a range of the vertices, the first of which is 1. */
static size_t pbwl__gather_vertices(void *arg, size_t from, size_t to, size_t at)
{
    const pbwl__gathering *gathering = (const pbwl__gathering *)arg;
    const pbwl__core *core = &gathering->live->core;
    size_t found = 0, v;
    for (v = from + 1; v <= to; v++) {
        if (core->incident[v] != PBWL__VERTEX_REMOVED) {
            if (at != PBWL__COUNT) {
                const double *x = pbwl__core_record(core, (pbw_index)v);
                pbwl__gathered_set(gathering->gathered, at + found, (pbw_index)v, x, x[core->kernel.dim]);
            }
            found++;
        }
    }
    return found;
}

/* Gathers the points of a range of numbers that live and have the vertex of another one, behind the vertices. */
static size_t pbwl__gather_duplicates(void *arg, size_t from, size_t to, size_t at)
{
    const pbwl__gathering *gathering = (const pbwl__gathering *)arg;
    const pbw_live *live = gathering->live;
    const pbwl__core *core = &live->core;
    size_t found = 0, i;
    for (i = from; i < to; i++) {
        if ((live->state[i] & PBWL__COMMITTED) != 0 && core->name[core->vertex[i]] != i) {
            if (at != PBWL__COUNT) {
                pbwl__gathered_set(gathering->gathered, gathering->gathered->count + at + found, core->vertex[i],
                                   pbwl__core_record(core, core->vertex[i]), live->weight[i]);
            }
            found++;
        }
    }
    return found;
}

/* Sorts the vertices, unless they are as a build sorted them.  Copies them to `gathered` if some were removed, or if
   there are duplicates, which count for the grid of the keys. */
static pbw_status pbwl__view_order(pbwl__viewing *viewing, pbw__context *context, pbwl__gathered *gathered,
                                   pbw__vertices *vertices)
{
    const pbw_live *live = viewing->live;
    const pbwl__core *core = &live->core;
    const size_t width = (size_t)live->dim + 1;
    pbwl__gathering gathering = { live, gathered };
    pbw__input input;
    if (core->unused_count == 0 && core->vertex_count == live->points && core->sorted) {
        viewing->sorted = 1;
        memset(vertices, 0, sizeof(*vertices));
        vertices->dim = live->dim;
        vertices->weighted = live->weighted_before;
        vertices->width = 1;
        vertices->count = vertices->point_count = live->points;
        vertices->id = core->name;
        return PBW_OK;
    }
    if (core->unused_count == 0 && core->vertex_count == live->points) {
        input = pbw__input_of(live->dim, 0, core->record + width, core->record + 2 * width - 1, live->points);
        input.weights = live->weighted_before ? input.weights : NULL;
        input.stride = input.weight_stride = width * sizeof(double);
        input.bare = 1;
        return pbw__order(context, &input, vertices);
    }
    if (!pbwl__gathered_create(context, gathered, live->points, live->dim)) {
        return PBW_ERROR_MEMORY;
    }
    gathered->count = pbwl__list(context, core->vertex_count, pbwl__gather_vertices, &gathering);
    if (gathered->count < live->points) {
        gathered->count += pbwl__list(context, live->numbers, pbwl__gather_duplicates, &gathering);
    }
    pbwl__gathered_input(gathered, live->weighted_before, &input);
    input.bare = core->vertex_count - core->unused_count == live->points;
    return pbw__order(context, &input, vertices);
}

/* ---- simplices */
/* Sets the rank of each vertex, and the id of each rank. */
static pbw_status pbwl__view_ranks(void *arg, size_t from, size_t to)
{
    const pbwl__viewing *viewing = (const pbwl__viewing *)arg;
    const pbw_index *name = viewing->live->core.name, *list = viewing->list;
    size_t r;
    for (r = from + 1; r <= to; r++) {
        const size_t soon = viewing->id[r + 16 <= to ? r + 16 : r], near = list != NULL ? list[soon] : soon + 1;
        const pbw_index v = list != NULL ? list[viewing->id[r]] : viewing->id[r] + 1;
        PBW__PREFETCH(name + near);
        PBW__PREFETCH_TO_WRITE(viewing->rank + near);
        viewing->id[r] = name[v];
        viewing->rank[v] = (pbw_index)r;
    }
    return PBW_OK;
}

/* Copies the corners of a range of slots as ranks. */
PBW__INLINE void pbwl__view_corners_of(const pbwl__viewing *viewing, size_t from, size_t to, int dim)
{
    const pbw_index *rank = viewing->rank;
    size_t t;
    for (t = from; t < to; t++) {
        const pbw_index *v = viewing->live->core.store.corner + 4 * t;
        pbw_index *r = viewing->corner + 4 * t;
        int k;
        r[0] = PBW_NONE;
        for (k = 0; k <= dim && v[0] != PBW_NONE; k++) {
            r[k] = rank[v[k]];
        }
    }
}

static pbw_status pbwl__view_corners(void *arg, size_t from, size_t to)
{
    const pbwl__viewing *viewing = (const pbwl__viewing *)arg;
    PBW__BY_DIM(viewing->live->dim, pbwl__view_corners_of, viewing, from, to);
    return PBW_OK;
}

/* Makes a store of ranks that borrows the core's links, with the slots of the build in regions; and its corners, if
   ranks are vertices. */
static pbw_status pbwl__view_store(pbwl__viewing *viewing, pbw__context *context, const pbw__vertices *vertices,
                                   pbw__store *store)
{
    const pbwl__core *core = &viewing->live->core;
    pbw_memory *memory = &context->memory;
    const size_t slots = core->store.count, vertex_entries = core->vertex_count + 1;
    pbw__block block[2];
    pbw_status status = PBW_ERROR_MEMORY;
    store->plain = 1;
    store->lent = viewing->sorted ? 2 : 1;
    store->link = core->store.link;
    store->count = store->capacity = slots;
    store->region_bits = pbw__region_bits(vertices->count, vertices->dim);
    store->region_count = (vertices->count >> store->region_bits) + 1;
    store->region_slots = core->store.region_slots < slots ? core->store.region_slots : slots;
    store->slots_each = store->region_slots / store->region_count + 1;
    store->hint = (pbw_index *)pbw__allocate(memory, store->region_count, sizeof(pbw_index));
    if (viewing->sorted) {
        store->corner = core->store.corner;
        return store->hint != NULL ? PBW_OK : PBW_ERROR_MEMORY;
    }
    store->corner = (pbw_index *)pbw__allocate(memory, 4 * slots, sizeof(pbw_index));
    store->corner_capacity = 4 * slots;
    viewing->corner = store->corner;
    viewing->id = vertices->id;
    viewing->rank = (pbw_index *)pbw__allocate(memory, vertex_entries, sizeof(pbw_index));
    block[0] = pbw__block_of(store->corner, 0, 4 * slots * sizeof(pbw_index));
    block[1] = pbw__block_of(viewing->rank, 0, vertex_entries * sizeof(pbw_index));
    pbw__populate(context, block, 2);
    if (store->hint != NULL && store->corner != NULL && viewing->rank != NULL) {
        viewing->rank[0] = PBW__GHOST;
        status = pbw__for_range(context, vertices->count, 16384, 0.0, pbwl__view_ranks, viewing);
        status = status == PBW_OK ? pbw__for_range(context, slots, 16384, 0.0, pbwl__view_corners, viewing) : status;
    }
    pbw__release(memory, viewing->rank, vertex_entries, sizeof(pbw_index));
    return status;
}

static pbw_status pbwl__view(const pbw_live *live, pbw__context *context, pbw_mesh *mesh)
{
    pbw_memory *memory = &context->memory;
    pbw__owned *owned = (pbw__owned *)pbw__allocate(memory, 1, sizeof(pbw__owned));
    pbwl__viewing viewing;
    pbwl__gathered gathered;
    pbw__vertices vertices;
    pbw__store store;
    pbw_status status;
    if (owned == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(owned, 0, sizeof(*owned));
    memset(&gathered, 0, sizeof(gathered));
    memset(&viewing, 0, sizeof(viewing));
    memset(&store, 0, sizeof(store));
    viewing.live = live;
    viewing.mesh = mesh;
    mesh->memory = owned;
    mesh->dim = live->dim;
    mesh->point_count = live->numbers;
    if (live->numbers == 0) {
        return PBW_DEGENERATE;
    }
    status = pbwl__view_begin(&viewing, context);
    if (status == PBW_OK && live->core.simplex_count == 0) {
        status = pbw__make_incident(context, owned, mesh, 1, NULL) == NULL ? PBW_ERROR_MEMORY : PBW_DEGENERATE;
    } else if (status == PBW_OK) {
        status = pbw__enter_stage(context, PBW_STAGE_ORDER) ? PBW_CANCELLED
               : pbwl__view_order(&viewing, context, &gathered, &vertices);
        viewing.list = gathered.list;
        if (status == PBW_OK) {
            status = pbw__enter_stage(context, PBW_STAGE_OUTPUT) ? PBW_CANCELLED
                   : pbwl__view_store(&viewing, context, &vertices, &store);
            status = status == PBW_OK ? pbw__output(context, &store, &vertices, PBW_BORROW, owned, mesh) : status;
            store.link = NULL;                       /* the core's */
            store.corner = viewing.sorted ? NULL : store.corner;
            vertices.id = viewing.sorted ? NULL : vertices.id;
            pbw__store_free(memory, &store);
            pbw__vertices_free(context, &vertices);
        }
    }
    pbwl__gathered_free(memory, &gathered);
    return status;
}

PBWDEF pbw_status pbw_live_view(pbw_live *live, pbw_mesh *mesh)
{
    pbw__context context;
    pbw_status status;
    pbw__fp fp;
    if (mesh == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(mesh, 0, sizeof(*mesh));
    if (live == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    fp = pbw__fp_enter();
    pbwl__context_start(live, &context, live->points);
    context.memory.used = live->memory.used;         /* the limit covers what `live` holds */
    live->core.kernel.context = &context;
    status = pbw__fp_is_exact() ? pbwl__view(live, &context, mesh) : PBW_ERROR_FP_MODE;
    live->core.kernel.context = NULL;
    pbw__team_stop(&context);
    if (mesh->memory != NULL) {
        ((pbw__owned *)mesh->memory)->memory = context.memory;
    }
    mesh->statistics.threads = context.threads;
    mesh->statistics.peak_bytes = context.memory.peak;
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        pbw_free(mesh);
    }
    pbw__fp_leave(fp);
    return status;
}
#ifdef _WIN32
#pragma pop_macro("far")
#pragma pop_macro("near")
#endif
PBW__SEAM_END
#endif
#endif /* PBW_LIVE_IMPLEMENTATION */
