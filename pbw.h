/* pbw.h - v0.2.0 - exact Delaunay and regular triangulation in 2D and 3D - MIT-0

   QUICK START
   In one source file, define PBW_IMPLEMENTATION before the include; in all others, only include.

       #define PBW_IMPLEMENTATION
       #include "pbw.h"
       #include <stdio.h>

       int main(void) {
           double points[] = { 0,0,0,  1,0,0,  0,1,0,  0,0,1,  1,1,1 };   // five points in space
           static pbw_mesh mesh;                                   // all zero: empty
           pbw_status status = pbw_triangulate(3, points, NULL, 5, NULL, &mesh);
           if (status != PBW_OK) { printf("%s\n", pbw_status_string(status)); return 1; }
           for (size_t i = 0; i < mesh.simplex_count; i++) {
               const pbw_index *corner = mesh.simplices + 4 * i;
               printf("%u %u %u %u\n", corner[0], corner[1], corner[2], corner[3]);
           }
           pbw_free(&mesh);
           return 0;
       }

   Build:  cc -O2 quickstart.c -lpthread

   FUNCTIONS
     pbw_triangulate         simplices, neighbours, duplicates and hidden points of points
     pbw_triangulatef        the same of floats
     pbw_free                frees a mesh
     pbw_hash                one number for a triangulation
     pbw_hash_parts          sums for the hash of a triangulation in parts
     pbw_hash_of             the hash of such sums
     pbw_orient2             on which side of a line a point is, exactly
     pbw_orient3             on which side of a plane
     pbw_incircle            whether a point is in the circle of three others
     pbw_insphere            whether it is in the sphere of four others
     pbw_power2              the same with weights, in the plane
     pbw_power3              the same with weights, in space
     pbw_for                 calls a function for ranges of numbers, on all threads
     pbw_threads_start       threads that several calls share
     pbw_threads_stop        ends them
     pbw_order               the order of points along a Hilbert curve
     pbw_conflict2           whether a point is in conflict with a triangle, ties decided
     pbw_conflict3           whether it is with a tetrahedron
     pbw_atomic_max          raises a number that threads share
     pbw_memory_start        one call's memory: an allocator, a limit
     pbw_memory_left         what is left of the limit
     pbw_memory_nest         makes the calls inside a call count in its memory
     pbw_memory_resize       allocates, resizes and frees
     pbw_memory_fit          the same of an array that knows its capacity: PBW_FIT, PBW_RELEASE
     pbw_memory_grow         room for more items of an array: PBW_RESERVE, PBW_PUSH
     pbw_memory_zeros        an array of zeros: PBW_ZEROS
     pbw_sort                the order of 64-bit keys
     pbw_sort_key            a key for a double
     pbw_mix                 mixes 64 bits
     pbw_random              item i of a stream of random numbers
     pbw_two_sum             a sum and its rounding error
     pbw_two_product         a product and its rounding error
     pbw_pair_plus           the sum of two pairs of doubles
     pbw_pair_times          their product
     pbw_pair_minor          a determinant of four pairs
     pbw_sign_of_products    the sign of a sum of products, exactly
     pbw_centre              the centre of a simplex
     pbw_status_string       a status in words
     pbw_version             of the implementation
     pbw_cuda_backend        makes pbw_triangulate work on a GPU
     pbw_cuda_backend_multi  on several GPUs
     pbw_cuda_triangulate    a triangulation that stays on the GPU
     pbw_cuda_check          proves it right there
     pbw_cuda_free           frees it
     pbw_cuda_loop_create    points that move on the GPU
     pbw_cuda_loop_step      triangulates them at their new places
     pbw_cuda_cells_of       cells of such a triangulation
     pbw_cuda_cells_of_host  cells of points in the host's memory
     pbw_cuda_cells_periodic  the same in a box that repeats
     pbw_cuda_cells_free     frees them
     pbw_cuda_loop_cells     cells of points that move
     pbw_cuda_loop_free      frees them

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>platform     compilers, atomics, clocks, floating-point state, the system's threads
     >>lanes        four numbers at once: AVX2, NEON
     >>memory       the one allocator hook, limits, pages of large blocks
     >>threads      one call's team of threads, tasks, progress
     >>exact        integers of just enough width
     >>grid         the coarsest grid that holds all records
     >>predicates   signs: filter, exact stage, perturbation
     >>curve        keys on a Hilbert curve
     >>sort         a radix sort by several threads
     >>order        Hilbert keys, sorting, duplicates
     >>mesh         simplices, ghosts, one thread's view of them, invariants
     >>slots        where simplices are stored
     >>walk         point location
     >>cavity3      in space: find, carve, refill
     >>cavity2      in the plane: find, carve, refill
     >>build        insertion, its order, the seed simplex, levels
     >>parallel     ownership; a level by many threads
     >>number       canonical order
     >>output       from the store to the caller's arrays, in place
     >>hash         one number for a triangulation
     >>tools        what companion headers build on
     >>seam         private names that pbw_check.h, pbw_query.h and pbw_live.h use
     >>api          argument checks, the stages in order, backends, status texts
     >>history      versions
     >>license      MIT No Attribution

   DOES      Delaunay triangulations (weights NULL) and regular triangulations (weights given) of points in
             the plane and in space: simplices, neighbours, one incident simplex for each point, duplicates,
             hidden points; a hash of the result; exact predicates.
   DOES NOT  which simplex contains a point, nearest vertices, interpolation (pbw_query.h does); points that come, go
             and move (pbw_live.h); an exact check of a triangulation (pbw_check.h); constraints, periodic domains,
             meshing (other companions); dimensions above 3.

   PROMISES  (and the test that guards each)
     exact       every sign is the true sign for every finite double; no epsilon anywhere   tests/test_predicates.c
     one answer  the triangulation is a function of the set of (weighted) points alone      tests/test_answer.c
     never exits no assert, abort, exit or print on your input; failures are statuses       tests/test_api.c
     re-entrant  no globals, no init call; many builds at once                              tests/test_api.c
     bounded     no recursion; a 256 KiB stack is enough, without optimisation 1 MiB        tests/test_resources.c
     no calls    one thread with the caller's memory makes no system call                   tests/test_syscalls.c

   CONVENTIONS
            3            A simplex has dim+1 corners; neighbor i is across the facet opposite to corner i.
           /|\           3D: det[b-a, c-a, d-a] > 0 for corners a b c d: seen from d, the corners a b c turn
          / | \              counter-clockwise.  (Shewchuk's orient3d has the opposite sign.)
         0--+--2         2D: corners turn counter-clockwise.
          \ | /          Hull: neighbor PBW_NONE.
           \|/           Power distance of x to a point p with weight w: |x-p|^2 - w.  A larger weight wins more.
            1
     Ties.  More than dim+1 points on one empty sphere leave the Delaunay triangulation undecided. Then the
     lift |p|^2 - w of each point is raised by a symbolic amount, infinitesimal against everything finite; the
     amounts are ordered by the lexicographic (x, y, z) order of the points, and the largest point's amount
     dominates (Devillers and Teillaud 2011, "Perturbations for Delaunay and weighted Delaunay 3D
     triangulations").  Orientations are never perturbed, so there are no flat simplices.
     Duplicates.  Of points at one place the one with the largest weight stays; ties keep the lowest index;
     -0.0 equals 0.0.  The others are listed in mesh.canonical.
     Hidden points (weights only).  A point whose power cell is empty is no vertex; mesh.incident says PBW_NONE.

   GLOSSARY  (the one meaning of a word in what follows)
     facet    of a simplex: an edge in the plane, a triangle in space; a ridge is a facet of that
     star     the simplices round a vertex; cavity: the simplices in conflict with a point, which its star replaces
     ghost    the vertex at infinity; a ghost simplex joins it to a facet of the hull
     lift     |p|^2 - w, the height of a point on the paraboloid; height of a row: what bounds its rounding errors
     rank     the number of a vertex along the Hilbert curve; a span is a sequence of ranks
     level    the ranks that are inserted before finer ones
     slot     where the store keeps a simplex; a region is the slots for a span; a fresh slot was never used
     zone     the ranks of one or more regions that one task owns at a time
     cell     a box of a grid; a power cell where that is said
     run      points in one cell of the curve's grid: equal keys
     task     a call of a function on some thread; a share: the items that one task begins with
     part     a range of the sorted keys; of queries a range is a block, elsewhere a block is memory
     position of a simplex, in the caller's arrays; place: of a point, its coordinates
     open     a sign that a stage of a predicate does not know

   COMPILING
     C99 or later, C++11 or later.  Optimise (-O2): without that every call takes eight times as long.  32-bit x86
     needs -msse2 -mfpmath=sse.

   CONFIGURATION MACROS
     PBW_IMPLEMENTATION   in one source file: compile the implementation there
     PBW_STATIC           everywhere: make every function static (several private copies in one program)
     PBWDEF               everywhere: your own linkage for the public functions.  Both hold for the headers beside it
     PBW_CUDA             where a program calls pbw_cuda.cu: declares its functions; nvcc needs no such macro
     PBW_WIDE             where PBW_IMPLEMENTATION is: 64-bit links, up to 4.29e9 simplices instead of 1.07e9,
                          for 16 more bytes a simplex while building
     PBW_NO_SIMD          where PBW_IMPLEMENTATION is: scalar code only; the same answers, slower.  Without it gcc and
                          clang make vector code too: AVX2, used where a build finds it, and NEON on 64-bit Arm
     PBW_NO_THREADS       where PBW_IMPLEMENTATION is: every call runs on the caller's thread, nothing to link.
                          Without it gcc and clang use pthreads, or the threads of Windows 7; MSVC uses these for
                          64-bit x86, elsewhere none
*/
#ifndef PBW_H
#define PBW_H
/* ------------------------------------------------------------------------------------------------------
   >>interface
   ------------------------------------------------------------------------------------------------------ */
#include <stddef.h>
#include <stdint.h>
#if defined(_MSC_VER) && defined(_M_X64)
#include <intrin.h>                        /* atomics */
#endif

#define PBW_VERSION_MAJOR 0
#define PBW_VERSION_MINOR 2
#define PBW_VERSION_PATCH 0
#define PBW_VERSION (PBW_VERSION_MAJOR * 10000 + PBW_VERSION_MINOR * 100 + PBW_VERSION_PATCH)

#ifndef PBWDEF
#if defined(PBW_STATIC) && defined(__GNUC__)
#define PBWDEF static __attribute__((unused))
#elif defined(PBW_STATIC)
#define PBWDEF static
#else
#define PBWDEF extern
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef uint32_t pbw_index;                /* a point or a simplex */
#define PBW_NONE 0xffffffffu               /* no such: outside the hull, not a vertex */

typedef enum pbw_status {                  /* every function that can fail returns one; 0 is success */
    PBW_OK = 0,
    PBW_DEGENERATE,                        /* the points span less than dim dimensions: no simplices */
    PBW_CANCELLED,                         /* the progress callback said stop */
    PBW_ERROR_ARGUMENT,                    /* NULL, bad dim, bad stride, bad thread count, bad flag */
    PBW_ERROR_NOT_FINITE,                  /* a coordinate or weight is NaN or infinite */
    PBW_ERROR_TOO_LARGE,                   /* more points or simplices than an index can number */
    PBW_ERROR_MEMORY,                      /* out of memory, or over options.memory_limit */
    PBW_ERROR_THREAD,                      /* a backend could start no thread; the CPU then works on the caller's */
    PBW_ERROR_FP_MODE,                     /* the arithmetic of this thread is not IEEE 754 double */
    PBW_ERROR_BACKEND                      /* the backend failed or does not fit this version */
} pbw_status;

typedef enum pbw_stage {
    PBW_STAGE_ORDER, PBW_STAGE_BUILD, PBW_STAGE_OUTPUT, PBW_STAGE_CHECK,
    PBW_STAGE_WORK                         /* of pbw_for, pbw_hash and queries */
} pbw_stage;

typedef struct pbw_mesh pbw_mesh;
typedef struct pbw_backend pbw_backend;

#define PBW_ANY_ORDER    1u                /* skip the canonical order of simplices: faster, still deterministic
                                              on one thread, but not the same arrays for all thread counts */
#define PBW_NO_NEIGHBORS 2u                /* leave mesh.neighbors NULL */
#define PBW_BACKEND_OR_CPU 4u              /* where options.backend cannot work, use the CPU */
#define PBW_CURVE_ORDER  8u                /* number the mesh's points along the curve, as pbw_order does: loops over
                                              its simplices and points then run in the cache, 1.7 to 5 times as fast
                                              for many points; mesh.original has the caller's numbers */
#define PBW_BORROW      16u                /* mesh.points and weights are the caller's packed doubles, not copies:
                                              they must outlive the mesh.  With floats, strides or
                                              PBW_CURVE_ORDER it is PBW_ERROR_ARGUMENT */

typedef struct pbw_options {               /* NULL or all zero = best defaults */
    int      threads;                      /* 0 = one per core, 1 = start none; at most 256 */
    unsigned flags;                        /* PBW_ANY_ORDER and so on, or'ed */
    size_t   stride, weight_stride;        /* bytes from one point / weight to the next, 0 = packed */
    size_t   memory_limit;                 /* bytes held at once, 0 = no limit; over it: PBW_ERROR_MEMORY.  As much
                                              again on each device of a backend; over that: PBW_ERROR_BACKEND */
    /* The one allocator: ptr NULL allocates, new_size 0 frees, else resizes as realloc does (NULL = failed and
       the old block stays).  old_size: of the block at ptr, 0 for NULL.  Blocks must be aligned as malloc's are.  It
       may be called from several threads at once unless threads is 1.  pbw_free calls it too, with resize_user: both
       must outlive the mesh.  NULL = realloc and free. */
    void *(*resize)(void *user, void *ptr, size_t old_size, size_t new_size);
    /* The caller's job system: calls task(arg, i) once for each i in 0..tasks-1, in any order, on any thread, and
       returns when all have returned.  Tasks never wait on each other.  NULL = our own threads.  Not called where a
       build has no threads: see PBW_NO_THREADS. */
    void  (*run)(void *user, int tasks, void (*task)(void *arg, int i), void *arg);
    /* Called on the caller's thread at least ten times a second; done runs from 0 to 1 in each stage.  A nonzero
       answer ends the call with PBW_CANCELLED within 100 ms.  With options.run, progress is reported only while the
       caller's own thread runs tasks. */
    int   (*progress)(void *user, pbw_stage stage, double done);
    void *resize_user, *run_user, *progress_user;      /* the first argument, `user`, of each */
    const pbw_backend *backend;            /* NULL = this CPU */
    uint32_t *trace;                       /* NULL, or an entry for each point, to be filled: thread + 256 * round,
                                              the thread that inserted it and in which round; PBW_NONE for duplicates
                                              and for points that a backend inserted */
    char    *message;                      /* NULL, or room for a text: what a backend lacked */
    size_t   message_size;                 /* its bytes; the text is cut to fit and ends with a 0 */
} pbw_options;

typedef struct pbw_statistics {            /* of the build that filled a mesh */
    double order_seconds, build_seconds, output_seconds;
    size_t peak_bytes;                     /* most memory held through options.resize at one time */
    size_t walk_steps;                     /* simplices visited by point location */
    size_t conflict_tests, exact_tests;    /* sphere tests made; those that the filter left to exact stages */
    size_t created;                        /* simplices created, ghosts included */
    int threads;                           /* that took part */
    size_t rounds, postponed;              /* of several threads; insertions put off to the next round, as they met
                                              another thread's or found no free slot */
    size_t serial;                         /* points inserted while there was work for one thread only */
    int by_backend;                        /* 1: options.backend built this, 0: the CPU */
} pbw_statistics;

struct pbw_mesh {                          /* start from {0}, in C++ {}; read, do not write; pbw_free when done */
    int dim;                               /* 2 or 3; a simplex has dim+1 corners */
    size_t point_count, simplex_count;
    const pbw_index *simplices;            /* simplex_count*(dim+1) ids of the caller's points, positively oriented;
                                              the first corner comes first on the Hilbert curve */
    const pbw_index *neighbors;            /* same shape; entry i is across from corner i, PBW_NONE on the hull */
    const pbw_index *incident;             /* per point: the first simplex that has it, PBW_NONE if it is no vertex */
    const pbw_index *canonical;            /* per point: itself, or the point that it duplicates; PBW_NONE for a
                                              number without a point, as pbw_live_view (pbw_live.h) gives */
    size_t duplicate_count, hidden_count;  /* why a point may be no vertex */
    const pbw_index *original;             /* with PBW_CURVE_ORDER, per point: its number in the caller's arrays; else
                                              NULL, the numbers are the caller's */
    const double *points, *weights;        /* the library's own packed copies, or the caller's (PBW_BORROW); weights
                                              NULL if none were given */
    pbw_statistics statistics;
    void *memory;                          /* private */
};

/* Triangulates count points; weights NULL = Delaunay, else regular.
   points: dim coordinates each, read in place, not kept (but see PBW_BORROW); weights: one each.  mesh: overwritten
   (an earlier result in it is not freed); on any status but PBW_OK and PBW_DEGENERATE it is left empty.
   PBW_DEGENERATE: no simplices, but canonical, incident (all PBW_NONE), points and duplicate_count are filled.
   On uniform points it holds at most 280 (3D) or 97 (2D) bytes a point while it runs, and 0.5 MB a thread.  The mesh
   has at most 260 (3D) or 85 (2D) bytes a point, with PBW_BORROW 24 or 16 less. */
PBWDEF pbw_status pbw_triangulate(int dim, const double *points, const double *weights, size_t count,
                                  const pbw_options *options, pbw_mesh *mesh);
/* As pbw_triangulate, for floats: the exact triangulation of those float values. */
PBWDEF pbw_status pbw_triangulatef(int dim, const float *points, const float *weights, size_t count,
                                   const pbw_options *options, pbw_mesh *mesh);
/* Frees what a mesh holds and zeroes it; fine on {0}, fine twice. */
PBWDEF void pbw_free(pbw_mesh *mesh);

/* A backend computes the same arrays elsewhere: pbw_cuda.cu has one for NVIDIA GPUs.  Where it fails, and that is no
   matter of the input, the call ends with PBW_ERROR_BACKEND, or is left to the CPU under PBW_BACKEND_OR_CPU; an input
   that the backend declines always is.  To write one: fill a pbw_backend; its triangulate gets a job, fills it and
   returns PBW_OK, or a status and, by say, the reason. */
typedef struct pbw_job pbw_job;
struct pbw_job {
    int dim, is_float, threads;            /* arguments checked; is_float: points and weights are floats */
    unsigned flags;
    size_t count, stride, weight_stride;   /* bytes; count is at least 1 */
    const void *points, *weights;          /* weights NULL = Delaunay */
    /* Copies points and weights into the mesh, packed and as doubles, -0.0 as 0.0: kept_points, kept_weights.  To be
       called at most once, when it suits; if not, it is done in the end. */
    pbw_status (*keep)(pbw_job *job);
    /* Allocates simplices, neighbors (not with PBW_NO_NEIGHBORS), incident and canonical, once. */
    pbw_status (*reserve)(pbw_job *job, size_t simplex_count);
    int  (*report)(pbw_job *job, pbw_stage stage, double done);       /* progress; nonzero: return PBW_CANCELLED */
    void (*say)(pbw_job *job, const char *text);                      /* into options.message */
    const double *kept_points, *kept_weights;
    pbw_index *simplices, *neighbors, *incident, *canonical;          /* to be filled as in pbw_mesh */
    size_t duplicate_count, hidden_count;                             /* to be set */
    int declined;                          /* set to 1 and return PBW_ERROR_BACKEND: this input is for the CPU */
    void *context;                         /* private */
    size_t memory_limit;                   /* as in the options; of a backend's own memory: on each device */
};

struct pbw_backend {
    int version;                           /* PBW_VERSION of the header that it was compiled with */
    pbw_status (*triangulate)(const pbw_backend *backend, pbw_job *job);
    void *user;                            /* the backend's own */
};

typedef struct pbw_report {                /* what a check found: pbw_check in pbw_check.h, pbw_cuda_check */
    int valid;                             /* 1: the mesh is the triangulation that pbw_triangulate promises */
    const char *what;                      /* the first fault in words, "" if valid; never freed */
    pbw_index simplex, facet;              /* of the fault, or PBW_NONE; a facet by its opposite corner */
    pbw_index point;                       /* of the fault, or PBW_NONE */
    size_t vertex_count, facet_count, hull_facet_count;   /* counted until the first fault */
} pbw_report;

/* Equal for two meshes if and only if (up to 2^-64 chance) they are the same triangulation of the same points:
   independent of the order of points and simplices, of ids, and of float or double input.  Returns 0 for an empty
   mesh, a bad argument, a corner that is no canonical point, and if options.progress cancels. */
PBWDEF uint64_t pbw_hash(const pbw_mesh *mesh, const pbw_options *options);

/* The two sums of which pbw_hash is made, over chosen points and simplices: `points` and `simplices` have a byte for
   each, nonzero for those chosen; NULL = all.  Sums of disjoint choices add up, member by member and modulo 2^64: so
   the hash of a triangulation that is too large for one memory is pbw_hash_of the sums of its parts.  Holds 8 bytes a
   point; where memory is too short for them it takes longer. */
typedef struct pbw_hash_sums { uint64_t points, simplices; } pbw_hash_sums;
PBWDEF pbw_status pbw_hash_parts(const pbw_mesh *mesh, const unsigned char *points, const unsigned char *simplices,
                                 const pbw_options *options, pbw_hash_sums *sums);
PBWDEF uint64_t pbw_hash_of(const pbw_hash_sums *sums);

/* Exact signs -1, 0, +1 for all finite doubles, in every rounding mode; no setup, any thread.
   orient: +1 if the simplex is positively oriented (see CONVENTIONS).
   incircle, insphere: +1 if p is inside the circle / sphere through the corners of a positively oriented simplex;
   the sign flips with the orientation.  power2, power3: the same with weights, w[i] for corner i and last for p:
   +1 if p is below the lifted plane through the corners, that is, in conflict with the simplex. */
PBWDEF int pbw_orient2(const double a[2], const double b[2], const double c[2]);
PBWDEF int pbw_orient3(const double a[3], const double b[3], const double c[3], const double d[3]);
PBWDEF int pbw_incircle(const double a[2], const double b[2], const double c[2], const double p[2]);
PBWDEF int pbw_insphere(const double a[3], const double b[3], const double c[3], const double d[3],
                        const double p[3]);
PBWDEF int pbw_power2(const double a[2], const double b[2], const double c[2], const double p[2], const double w[4]);
PBWDEF int pbw_power3(const double a[3], const double b[3], const double c[3], const double d[3], const double p[3],
                      const double w[5]);

/* ---- for companion headers, and for loops of your own over a mesh */

/* Calls body(arg, from, to) once for each range of `grain` items, 0..grain-1, grain..2*grain-1, ..., the last one cut
   at `count`: the same ranges for any number of threads, begun in ascending order, several at once.  They run on
   options.threads threads or by options.run, in IEEE double arithmetic, rounded to nearest.  A status other than
   PBW_OK ends the call: ranges that have begun are finished.  Returns the status of the lowest range that failed,
   again the same for any number of threads.  Progress is PBW_STAGE_WORK, before each range. */
typedef pbw_status pbw_body(void *arg, size_t from, size_t to);
PBWDEF pbw_status pbw_for(const pbw_options *options, size_t count, size_t grain, pbw_body *body, void *arg);

/* Starts threads for calls on about `count` points.  *inner becomes *options (NULL: all zero), with the number of
   threads that could be had, and calls with it or a copy of it run on these: one at a time, none inside of another's
   tasks, none in a child of fork.  inner may be options.  Returns NULL where there are none to start, where memory is
   short and where options.run is set: calls with *inner then do as with *options.
   stop: ends the threads, after the last call with *inner; fine on NULL. */
typedef struct pbw_threads pbw_threads;
PBWDEF pbw_threads *pbw_threads_start(const pbw_options *options, size_t count, pbw_options *inner);
PBWDEF void pbw_threads_stop(pbw_threads *threads);

/* Fills order with 0..count-1 in the order of a Hilbert curve through the points; points at one place follow each
   other, ascending.  Reads points as pbw_triangulate does (options.stride) and fails as it does. */
PBWDEF pbw_status pbw_order(int dim, const double *points, size_t count, const pbw_options *options,
                            pbw_index *order);

/* Returns 1 if p is in conflict with the positively oriented simplex: inside its circle or sphere (with weights:
   below its lifted plane), or, by the tie rule of CONVENTIONS, on it; else 0.  w: weights of the corners, then of p,
   or NULL.  p and the corners are at different places. */
PBWDEF int pbw_conflict2(const double a[2], const double b[2], const double c[2], const double p[2],
                         const double w[4]);
PBWDEF int pbw_conflict3(const double a[3], const double b[3], const double c[3], const double d[3],
                         const double p[3], const double w[5]);

/* ---- the base: what companion headers are built of.  Nothing here is needed to triangulate. */
#ifndef PBW__DEVICE                        /* pbw_cuda.cu compiles some of it for the GPU too */
#define PBW__DEVICE
#endif
#if defined(__GNUC__)
#define PBW__HOST_INLINE static __inline __attribute__((always_inline, unused))
#define PBW_PREFETCH(address) __builtin_prefetch(address)
#else
#define PBW__HOST_INLINE static __inline
#define PBW_PREFETCH(address) ((void)(address))
#endif
#define PBW_INLINE PBW__DEVICE PBW__HOST_INLINE

/* Around code that must round each product and each sum, as fused operations give other numbers: OFF before the first
   function, ON after the last. */
#if defined(__clang__)
#define PBW_CONTRACTION_OFF _Pragma("STDC FP_CONTRACT OFF")
#define PBW_CONTRACTION_ON _Pragma("STDC FP_CONTRACT DEFAULT")
#define PBW__NOT_FUSED _Pragma("STDC FP_CONTRACT OFF")          /* first in a function */
#elif defined(__GNUC__)
#define PBW_CONTRACTION_OFF _Pragma("GCC push_options") _Pragma("GCC optimize(\"fp-contract=off\")")
#define PBW_CONTRACTION_ON _Pragma("GCC pop_options")
#define PBW__NOT_FUSED
#else
#define PBW_CONTRACTION_OFF
#define PBW_CONTRACTION_ON
#define PBW__NOT_FUSED
#endif

/* Words that threads share, in relaxed order; x: the address of an integer of 1, 4 or 8 bytes, for ADD of 4 or 8.
   PBW_ATOMIC_ADD returns the value before; PBW_ATOMIC_CAS whether *x was *old and became y, else *old becomes what *x
   is, and it may fail where they are equal. */
#if defined(__GNUC__)
#define PBW_ATOMIC_LOAD(x) __atomic_load_n(x, __ATOMIC_RELAXED)
#define PBW_ATOMIC_STORE(x, y) __atomic_store_n(x, y, __ATOMIC_RELAXED)
#define PBW_ATOMIC_ADD(x, y) __atomic_fetch_add(x, y, __ATOMIC_RELAXED)
#define PBW_ATOMIC_CAS(x, old, y) __atomic_compare_exchange_n(x, old, y, 1, __ATOMIC_RELAXED, __ATOMIC_RELAXED)
#elif defined(_MSC_VER) && defined(_M_X64)
#define PBW_ATOMIC_LOAD(x) pbw__atomic_load(x, sizeof(*(x)))
#define PBW_ATOMIC_STORE(x, y) pbw__atomic_store(x, (uint64_t)(y), sizeof(*(x)))
#define PBW_ATOMIC_ADD(x, y) pbw__atomic_add(x, (uint64_t)(y), sizeof(*(x)))
#define PBW_ATOMIC_CAS(x, old, y) pbw__atomic_cas(x, old, (uint64_t)(y), sizeof(*(x)))
/* Words of 1, 4 or 8 bytes by the intrinsics of MSVC; the barriers are for the compiler. */
PBW__HOST_INLINE uint64_t pbw__atomic_load(const volatile void *x, size_t size)
{
    const uint64_t value = size == 1 ? *(const volatile uint8_t *)x : size == 4 ? *(const volatile uint32_t *)x
                                                                                : *(const volatile uint64_t *)x;
    _ReadWriteBarrier();
    return value;
}

PBW__HOST_INLINE void pbw__atomic_store(volatile void *x, uint64_t y, size_t size)
{
    _ReadWriteBarrier();
    if (size == 1) {
        *(volatile uint8_t *)x = (uint8_t)y;
    } else if (size == 4) {
        *(volatile uint32_t *)x = (uint32_t)y;
    } else {
        *(volatile uint64_t *)x = y;
    }
}

PBW__HOST_INLINE uint64_t pbw__atomic_add(volatile void *x, uint64_t y, size_t size)
{
    return size == 4 ? (uint32_t)_InterlockedExchangeAdd((volatile long *)x, (long)y)
                     : (uint64_t)_InterlockedExchangeAdd64((volatile __int64 *)x, (__int64)y);
}

/* Returns whether *x was *old and became y; else *old becomes what *x is. */
PBW__HOST_INLINE int pbw__atomic_cas(volatile void *x, void *old, uint64_t y, size_t size)
{
    const uint64_t expected = pbw__atomic_load(old, size), value = size == 1
        ? (uint8_t)_InterlockedCompareExchange8((volatile char *)x, (char)y, (char)expected) : size == 4
        ? (uint32_t)_InterlockedCompareExchange((volatile long *)x, (long)y, (long)expected)
        : (uint64_t)_InterlockedCompareExchange64((volatile __int64 *)x, (__int64)y, (__int64)expected);
    pbw__atomic_store(old, value, size);
    return value == expected;
}
#else                                                /* there the library starts no threads */
#define PBW_ATOMIC_LOAD(x) (*(x))
#define PBW_ATOMIC_STORE(x, y) ((void)(*(x) = (y)))
#define PBW_ATOMIC_ADD(x, y) ((*(x) += (y)) - (y))
#define PBW_ATOMIC_CAS(x, old, y) ((void)(old), *(x) = (y), 1)
#endif

PBW__HOST_INLINE void pbw_atomic_max(size_t *x, size_t y)          /* raises *x to y if it is lower */
{
    size_t old = PBW_ATOMIC_LOAD(x);
    while (old < y && !PBW_ATOMIC_CAS(x, &old, y)) {
    }
}

/* The memory of a call, through one allocator.  Any thread may use it.  Large blocks get huge pages if there are any,
   but not those of a caller's allocator.  Holds: used = the bytes of all its blocks <= peak <= a limit. */
typedef struct pbw_memory {
    void *(*resize)(void *user, void *ptr, size_t old_size, size_t new_size);        /* as in pbw_options */
    void *user;
    size_t limit, used, peak;
} pbw_memory;

/* With the allocator and memory_limit of the options, which may be NULL. */
PBWDEF void pbw_memory_start(pbw_memory *memory, const pbw_options *options);
/* The memory_limit for a call within this one: 0 = none; 1 if nothing is left. */
PBWDEF size_t pbw_memory_left(const pbw_memory *memory);
/* Sets resize, resize_user and memory_limit of options so that calls with them count in `memory` if it has a limit.
   What such calls allocate must be freed while *memory exists. */
PBWDEF void pbw_memory_nest(pbw_memory *memory, pbw_options *options);
/* Resizes a block from old_count to count items of `size` bytes: ptr NULL allocates, count 0 frees and returns NULL.
   Returns NULL, and leaves the block, if memory is short or the limit reached, and if a size_t is too
   small for the bytes. */
PBWDEF void *pbw_memory_resize(pbw_memory *memory, void *ptr, size_t old_count, size_t count, size_t size);

/* A growing array, all zero when it is empty: items at[0] .. at[count - 1], room for capacity of them.  In the macros
   array is such a struct, an lvalue without side effects.  They return 1, or 0 and leave it as it is.
   PBW_FIT       changes the capacity
   PBW_ZEROS     count = wanted zeros, where there were no items; at is not NULL then, even of none
   PBW_RESERVE   room for `more` items behind the last; capacities grow by a quarter
   PBW_PUSH      puts an item behind the last; it is evaluated once, after the array has grown
   PBW_RELEASE   frees it: all zero again */
#define PBW_ARRAY(type) struct { type *at; size_t count, capacity; }
#define PBW_FIT(memory, array, wanted) \
    pbw_memory_fit(memory, &(array).at, &(array).capacity, wanted, sizeof *(array).at)
#define PBW_ZEROS(memory, array, wanted) \
    (pbw_memory_zeros(memory, &(array).at, &(array).capacity, wanted, sizeof *(array).at) \
     && ((array).count = (wanted), 1))
#define PBW_RESERVE(memory, array, more) \
    ((more) <= (array).capacity - (array).count \
     || pbw_memory_grow(memory, &(array).at, &(array).capacity, (array).count, more, sizeof *(array).at))
#define PBW_PUSH(memory, array, item) \
    (PBW_RESERVE(memory, array, 1) && ((array).at[(array).count] = (item), ++(array).count))
#define PBW_RELEASE(memory, array) ((void)((array).count = 0, PBW_FIT(memory, array, 0)))
/* For the macros; array: the address of a pointer. */
PBWDEF int pbw_memory_fit(pbw_memory *memory, void *array, size_t *capacity, size_t wanted, size_t size);
PBWDEF int pbw_memory_grow(pbw_memory *memory, void *array, size_t *capacity, size_t count, size_t more, size_t size);
PBWDEF int pbw_memory_zeros(pbw_memory *memory, void *array, size_t *capacity, size_t wanted, size_t size);

/* Fills order with 0..count-1 so that keys[order[i]] ascend; equal keys by index.  The same for any number of
   threads.  Takes 16 bytes an item.  Fails as pbw_for does. */
PBWDEF pbw_status pbw_sort(const uint64_t *keys, size_t count, const pbw_options *options, pbw_index *order);
PBWDEF uint64_t pbw_sort_key(double x);    /* in the order of the numbers, -0.0 as 0.0; NaN before or behind all */

/* Numbers that look random: a bijection of 64 bits, the finalizer of splitmix64, and item i of the stream of a key
   (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators", whose state is a counter). */
PBW_INLINE uint64_t pbw_mix(uint64_t x)
{
    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    return x ^ (x >> 31);
}

PBW_INLINE uint64_t pbw_random(uint64_t key, uint64_t i)
{
    return pbw_mix(key + (i + 1) * UINT64_C(0x9e3779b97f4a7c15));
}

/* Pairs of doubles, head + tail.  Where nothing over- or underflows, and between PBW_CONTRACTION_OFF and ON,
   pbw_two_sum (Knuth 1969) and pbw_two_product (Dekker 1971) are exact: head is the rounded result, tail its error.
   The latter uses the processor's fused operation where the compiler has it, and never the fma of a library, as some
   round twice.  The others round to some 105 bits, and normalise: |tail| <= 2^-53 |head|. */
#if !defined(PBW__FMA) && defined(__GNUC__) \
    && (defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__FP_FAST_FMA) || defined(__CUDA_ARCH__))
#define PBW__FMA 1                         /* 0, by tests: without fused operations of our own, and without vectors */
#endif

#ifdef __CUDA_ARCH__
#define PBW__TIMES(a, b) __dmul_rn(a, b)   /* nvcc fuses other products into sums */
#else
#define PBW__TIMES(a, b) ((a) * (b))
#endif

typedef struct pbw_pair { double head, tail; } pbw_pair;

PBW_INLINE pbw_pair pbw_two_sum(double a, double b)
{
    PBW__NOT_FUSED
    pbw_pair sum;
    double other;
    sum.head = a + b;
    other = sum.head - a;
    sum.tail = (a - (sum.head - other)) + (b - other);
    return sum;
}

PBW_INLINE pbw_pair pbw_two_product(double a, double b)
{
    PBW__NOT_FUSED
    pbw_pair product;
#if defined(PBW__FMA) && PBW__FMA
    product.head = __builtin_fma(a, b, 0.0);
    product.tail = __builtin_fma(a, b, -product.head);
#else
    double ca = 134217729.0 * a, ha = ca - (ca - a), ta = a - ha;        /* 2^27 + 1, halves of 26 bits */
    double cb = 134217729.0 * b, hb = cb - (cb - b), tb = b - hb;
    product.head = a * b;
    product.tail = ta * tb - (((product.head - ha * hb) - ta * hb) - ha * tb);
#endif
    return product;
}

PBW_INLINE pbw_pair pbw_pair_plus(pbw_pair a, pbw_pair b)
{
    pbw_pair sum = pbw_two_sum(a.head, b.head);
    return pbw_two_sum(sum.head, sum.tail + (a.tail + b.tail));
}

PBW_INLINE pbw_pair pbw_pair_times(pbw_pair a, pbw_pair b)
{
    PBW__NOT_FUSED
    pbw_pair product = pbw_two_product(a.head, b.head);
    return pbw_two_sum(product.head, product.tail + (PBW__TIMES(a.head, b.tail) + PBW__TIMES(a.tail, b.head)));
}

PBW_INLINE pbw_pair pbw_pair_minor(pbw_pair a, pbw_pair b, pbw_pair c, pbw_pair d)           /* a d - b c */
{
    b.head = -b.head;
    b.tail = -b.tail;
    return pbw_pair_plus(pbw_pair_times(a, d), pbw_pair_times(b, c));
}

/* Returns the sign, -1, 0 or 1, of a[0] b[0] + ... + a[count-1] b[count-1]: exact for all finite doubles. */
PBWDEF int pbw_sign_of_products(const double *a, const double *b, int count);

/* Computes where the bisectors of a simplex meet, with weights (or NULL) its radical planes, relative to corner[0]:
   in pairs of doubles from exact differences, with a relative error of some 1e-26 L^3 / V, where L is the longest
   edge at corner 0 and V six times the volume (in the plane L^2, twice the area).  corner: dim + 1 points, positively
   oriented.  Returns 0 if V < 1e-14 L^3, and the centre may be far off. */
PBW__DEVICE PBWDEF int pbw_centre(int dim, const double *const *corner, const double *weight, double *centre);

/* Corner k, 0 to 2, of the facet opposite to corner `facet` of a tetrahedron: the lowest first, counter-clockwise
   seen from outside.  {1,2,3}, {0,3,2}, {0,1,3}, {0,2,1}. */
#define PBW_FACET_CORNER(facet, k) (0x634b39u >> (6 * (unsigned)(facet) + 2 * (unsigned)(k)) & 3u)

PBWDEF const char *pbw_status_string(pbw_status status);    /* never NULL, never freed */
PBWDEF int pbw_version(void);              /* differs from PBW_VERSION if header and implementation do */

#if defined(PBW_CUDA) || defined(__CUDACC__)
/* ---- in pbw_cuda.cu, for programs that link it */
extern const pbw_backend *pbw_cuda_backend(int device);     /* NULL for a number that no device can have */
/* Several devices, of any kinds, for one triangulation: the same bytes.  Each holds all points, 90 bytes a point (2D:
   75), and its share of the rest, together 560 (155).  A device may be listed more than once.  NULL for more than 16,
   or a number that no device can have. */
extern const pbw_backend *pbw_cuda_backend_multi(const int *devices, int count);

typedef struct pbw_cuda_mesh {             /* start from {0}; arrays on the device, as in pbw_mesh */
    int dim, by_cpu;                       /* 1: the CPU built this */
    size_t point_count, simplex_count, duplicate_count, hidden_count;
    pbw_index *simplices, *neighbors, *incident, *canonical;
    float milliseconds[8];                 /* device: order, boxes, near, far, count, simplices, neighbors, all */
    size_t stars[3];                       /* that each rung was given */
    int kept;                              /* 1: in a loop, the mesh of the step before still held */
} pbw_cuda_mesh;

/* Triangulates packed points on the current device (floats if is_float), in the order of stream (a cudaStream_t; NULL
   is the default stream), and returns when the counts are known; the arrays are complete in the order of the stream.
   options: as for pbw_triangulate, but without stride, trace and backend.  cpu: pbw_triangulate, and what a backend
   would leave to the CPU is built by it: points are copied to the host, arrays to the device; or NULL, and the status
   is PBW_ERROR_BACKEND.  On any status but PBW_OK and PBW_DEGENERATE the mesh is left empty. */
typedef pbw_status pbw_triangulator(int dim, const double *points, const double *weights, size_t count,
                                    const pbw_options *options, pbw_mesh *mesh);
extern pbw_status pbw_cuda_triangulate(int dim, int is_float, const void *points, const void *weights, size_t count,
                                       const pbw_options *options, void *stream, pbw_triangulator *cpu,
                                       pbw_cuda_mesh *mesh);
/* Checks a mesh with simplices and neighbors as pbw_check does, on the device and exactly, against the points that it
   is of; but does not find hidden points that lie at one place.  report: as from pbw_check, the same first fault, but
   of several faulty hidden points it may name another. */
extern pbw_status pbw_cuda_check(const pbw_cuda_mesh *mesh, int is_float, const void *points, const void *weights,
                                 const pbw_options *options, void *stream, pbw_report *report);
extern void pbw_cuda_free(pbw_cuda_mesh *mesh, void *stream);

/* Points that move, triangulated step by step on one device: as by pbw_cuda_triangulate, with the same arrays, but a
   loop keeps device memory, events and pinned memory from step to step, so a step as large as one before it allocates
   nothing.  And it keeps the mesh: where that is still the triangulation of all points, which is tested exactly and
   takes a fraction of a build, it is not built again (mesh.kept); else it is.  Weights may change too.
   create: for the current device; options, stream and cpu are as above, for all steps; options are copied.
   step: the arrays belong to the loop, until the next step or pbw_cuda_loop_free: not for pbw_cuda_free.  With
   PBW_NO_NEIGHBORS every step builds.  A step that fails leaves the mesh empty, and the next one builds.
   free: fine on NULL; waits for the stream. */
typedef struct pbw_cuda_points {           /* start from {0}; packed, on the device */
    int dim, is_float;                     /* is_float: floats, not doubles */
    const void *points, *weights;          /* weights NULL = Delaunay */
    size_t count;
    int rebuild;                           /* 1: build without that test, as when all is known to have moved far */
} pbw_cuda_points;
typedef struct pbw_cuda_loop pbw_cuda_loop;
extern pbw_status pbw_cuda_loop_create(const pbw_options *options, void *stream, pbw_triangulator *cpu,
                                       pbw_cuda_loop **loop);
extern pbw_status pbw_cuda_loop_step(pbw_cuda_loop *loop, const pbw_cuda_points *points, pbw_cuda_mesh *mesh);
/* Computes the cells of a mesh's points, with weights power cells, in a box or, with NULL, in the whole space.  box:
   2*dim numbers of the host, low and high corner.  The arrays are those of pbw_cells_of (pbw_cells.h), byte for byte
   if that takes such coordinates.  points: of the mesh.  cpu: for points in a box that span no simplex; NULL = these
   give PBW_ERROR_BACKEND.  Other statuses are as from pbw_cells_of; on all but PBW_OK and PBW_DEGENERATE cells are
   left empty.  Needs 1 kB of the device a point in space, 1.4 with facets.  Waits for the stream.
   loop_cells: of the mesh of the last step.  The arrays belong to the loop until its next loop_cells: so centroids
   can be the points of the next step.  All others are for pbw_cuda_cells_free.
   of_host: of packed points of the host, by the current device or those of options.backend (pbw_cuda_backend_multi):
   the first makes the mesh, each an equal share of the cells.  The arrays are the host's.  Other options are
   as for pbw_cuda_triangulate; memory_limit is for mesh and cells, each, besides the points.
   periodic: of points in a box that repeats along axis k if bit k of axes is set; options likewise.  As from
   pbw_cells_periodic: byte for byte if copies within 3.2 spacings do, as for even points in space, else to rounding
   and the order of facets.  PBW_ERROR_BACKEND for few or very uneven points.  of_host: axes 0 = none. */
#define PBW_CUDA_FACETS 1u                 /* fill first, neighbors, areas */
typedef struct pbw_cuda_cells {            /* start from {0}; arrays on the device, as in pbw_cells */
    int dim;
    size_t cell_count, facet_count;
    double *volumes, *centroids;
    size_t *first;
    pbw_index *neighbors;
    double *areas;
    double *sites;                         /* periodic: as in pbw_cells; else NULL */
    signed char *shifts;
    float milliseconds[5];                 /* device: stars, shares, sums, cut cells, all */
    void *memory;                          /* private */
} pbw_cuda_cells;
extern pbw_status pbw_cuda_cells_of(const pbw_cuda_mesh *mesh, const pbw_cuda_points *points, const double *box,
                                    unsigned what, const pbw_options *options, void *stream, pbw_triangulator *cpu,
                                    pbw_cuda_cells *cells);
extern pbw_status pbw_cuda_cells_of_host(int dim, const double *points, const double *weights, size_t count,
                                         const double *box, unsigned axes, unsigned what,
                                         const pbw_options *options, pbw_triangulator *cpu, pbw_cuda_cells *cells);
extern pbw_status pbw_cuda_cells_periodic(const pbw_cuda_points *points, const double *box, unsigned axes,
                                          unsigned what, const pbw_options *options, void *stream,
                                          pbw_triangulator *cpu, pbw_cuda_cells *cells);
extern void pbw_cuda_cells_free(pbw_cuda_cells *cells, void *stream);
extern pbw_status pbw_cuda_loop_cells(pbw_cuda_loop *loop, const pbw_cuda_points *points, const double *box,
                                      unsigned what, pbw_cuda_cells *cells);
extern void pbw_cuda_loop_free(pbw_cuda_loop *loop);
#endif

#ifdef __cplusplus
}
#endif
#endif /* PBW_H */

/* Interface ends here; what follows is for those who want to know how it works. */

#if defined(PBW_IMPLEMENTATION) && !defined(__cplusplus) && !defined(_MSC_VER) \
    && (!defined(__STDC_VERSION__) || __STDC_VERSION__ < 199901L)
#error "pbw.h: compile the file with PBW_IMPLEMENTATION as C99 or later, or as C++11 or later"
#elif defined(PBW_IMPLEMENTATION) && !defined(PBW__IMPLEMENTED)
#define PBW__IMPLEMENTED
/* ------------------------------------------------------------------------------------------------------
   >>platform     Compilers, atomics, clocks, floating-point state, the system's threads.
   In: whatever the user compiles with.  Out: IEEE 754 double arithmetic, rounded to nearest, with no product
   fused into a sum unless we say so; or a compile error; or PBW_ERROR_FP_MODE.  Names for what compilers and systems
   do in different ways.
   ------------------------------------------------------------------------------------------------------ */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) \
    || defined(__NO_SIGNED_ZEROS__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || defined(_M_FP_FAST)
#error "pbw.h is exact only with IEEE arithmetic: compile without -ffast-math and without any part of it"
#endif

#include <float.h>
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD == 2)
#error "pbw.h is exact only where doubles are computed as doubles: on 32-bit x86 compile with -msse2 -mfpmath=sse"
#endif
#include <math.h>                                    /* HUGE_VAL; fabs and sqrt where no instruction serves */
#include <stdlib.h>
#include <string.h>
#ifndef _WIN32
#include <sched.h>                                   /* struct timespec, in strict C too */
#include <sys/time.h>
#include <time.h>
#endif
#if !defined(PBW_NO_THREADS) && (defined(__GNUC__) || (defined(_MSC_VER) && defined(_M_X64)))
#define PBW__THREADS 256                             /* at most */
#ifndef _WIN32
#include <pthread.h>
#include <unistd.h>
#endif
#endif
#if defined(PBW__THREADS) && defined(_WIN32)
#include <process.h>
#ifdef _MSC_VER
#include <intrin.h>
#endif
#endif
#ifdef _WIN32
#pragma push_macro("near")                           /* words to us, macros of windows.h */
#pragma push_macro("far")
#pragma push_macro("small")
#undef near
#undef far
#undef small
#endif
#ifdef __linux__
#include <sys/mman.h>
#ifndef __cplusplus
extern int madvise(void *address, size_t length, int advice);    /* strict C modes hide it */
#endif
#endif
#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__aarch64__) && defined(__ARM_NEON) && !defined(PBW_NO_SIMD)
#include <arm_neon.h>
#endif

/* Contraction must be off for both compilers; each ignores the other's pragma.  (gcc 12 fuses even so, in vector
   code of the form a*b +- c*d under -mfma: `make asm` looks for that in the predicates.)  gcc 13 moves two integers
   to a vector by an MMX register and does not reset the x87 unit, so that long doubles of a caller become NaN. */
#if defined(__clang__)
#if defined(__x86_64__) || defined(__i386__)
#pragma float_control(push)
#endif
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#ifdef __NVCC__                                      /* it hands the next pragmas on to gcc, with a warning */
#pragma nv_diagnostic push
#pragma nv_diag_suppress 1675
#endif
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
#pragma GCC optimize("no-tree-slp-vectorize")
#ifdef __NVCC__
#pragma nv_diagnostic pop
#endif
#ifdef _WIN32                                        /* gcc forgets that a vector function, called by a scalar one, */
#pragma GCC optimize("no-ipa-ra")                    /* clears the upper halves of registers that it must keep */
#endif
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif

#define PBW__INLINE PBW_INLINE
#define PBW__PREFETCH(address) PBW_PREFETCH(address)
#if defined(__GNUC__)
#define PBW__NOINLINE __attribute__((noinline))
#define PBW__LIKELY(x) __builtin_expect(!!(x), 1)
#define PBW__UNLIKELY(x) __builtin_expect(!!(x), 0)
#define PBW__PREFETCH_TO_WRITE(address) __builtin_prefetch(address, 1)
#else
#define PBW__NOINLINE
#define PBW__LIKELY(x) (x)
#define PBW__UNLIKELY(x) (x)
#define PBW__PREFETCH_TO_WRITE(address) ((void)(address))
#endif
/* For array[i], where `i` goes on to `end`: hardware prefetchers stop at page ends, this goes across them. */
#define PBW__PREFETCH_STREAM(array, i, end) PBW__PREFETCH((array) + ((i) + 512 < (end) ? (i) + 512 : (i)))

/* Calls f(..., dim), compiled for each dimension. */
#define PBW__BY_DIM(dim, f, ...) ((dim) == 3 ? f(__VA_ARGS__, 3) : f(__VA_ARGS__, 2))

/* The instructions of vectors: see >>lanes. */
#if !defined(PBW_NO_SIMD) && defined(__GNUC__) && !(defined(PBW__FMA) && PBW__FMA == 0)
#if defined(__x86_64__)
#define PBW__AVX2
/* prfchw: prefetch for writing; a no-op on AVX2 processors without it. */
#define PBW__SIMD __attribute__((target("avx2,fma,bmi,bmi2,popcnt,prfchw")))
#elif defined(__AARCH64EL__) && defined(__ARM_NEON)
#define PBW__NEON
#define PBW__SIMD
#endif
#endif

/* Hook for profilers, such as bench: called when an insertion enters a new phase. */
#ifndef PBW__PHASE
#define PBW__PHASE(phase) ((void)0)
#endif
enum { PBW__WALK, PBW__CAVITY, PBW__STAR, PBW__EXACT, PBW__OTHER };

/* Atomic access to words that threads share; in relaxed order, see >>threads and >>parallel. */
#ifdef PBW__THREADS
#define PBW__LOAD(x) PBW_ATOMIC_LOAD(x)
#define PBW__STORE(x, y) PBW_ATOMIC_STORE(x, y)
#define PBW__ADD(x, y) PBW_ATOMIC_ADD(x, y)
#define PBW__CAS(x, old, y) PBW_ATOMIC_CAS(x, old, y)
#else
#define PBW__LOAD(x) (*(x))
#define PBW__STORE(x, y) ((void)(*(x) = (y)))
#define PBW__ADD(x, y) ((*(x) += (y)) - (y))
#define PBW__CAS(x, old, y) ((void)(old), *(x) = (y), 1)
#endif
/* Release pairs with acquire: what was written before a release is visible after the acquire. */
#if defined(PBW__THREADS) && defined(__GNUC__)
#define PBW__STORE_RELEASE(x, y) __atomic_store_n(x, y, __ATOMIC_RELEASE)
#define PBW__LOAD_ACQUIRE(x) __atomic_load_n(x, __ATOMIC_ACQUIRE)
#define PBW__CAS_ACQUIRE(x, old, y) __atomic_compare_exchange_n(x, old, y, 0, __ATOMIC_ACQUIRE, __ATOMIC_RELAXED)
#define PBW__SUB_RELEASE(x, y) __atomic_fetch_sub(x, y, __ATOMIC_RELEASE)
#else                                                /* MSVC on x86-64: each load acquires, each store releases */
#define PBW__STORE_RELEASE(x, y) PBW__STORE(x, y)
#define PBW__LOAD_ACQUIRE(x) PBW__LOAD(x)
#define PBW__CAS_ACQUIRE(x, old, y) PBW__CAS(x, old, y)
#define PBW__SUB_RELEASE(x, y) PBW__ADD(x, 0 - (uint64_t)(y))
#endif
#if defined(PBW__THREADS) && !defined(__GNUC__)
#pragma warning(push)
#pragma warning(disable : 4244 4996)                 /* what is returned fits the word that it was read from; barriers
                                                        are called obsolete */
#endif

#define PBW__EPSILON 1.1102230246251565e-16          /* u = 2^-53: half an ulp of 1 */

PBW__INLINE double pbw__max(double a, double b)
{
    return a > b ? a : b;
}

PBW__INLINE double pbw__abs(double a)
{
    return fabs(a);
}

PBW__INLINE double pbw__max_abs(double a, double b, double c, double d)
{
    return pbw__max(pbw__max(pbw__abs(a), pbw__abs(b)), pbw__max(pbw__abs(c), pbw__abs(d)));
}

/* One instruction where possible, so that nothing needs libm. */
PBW__INLINE double pbw__square_root(double x)
{
#if defined(__SSE2__) && !defined(__CUDA_ARCH__)
    const __m128d y = _mm_set_sd(x);
    return _mm_cvtsd_f64(_mm_sqrt_sd(y, y));
#elif defined(__aarch64__) && defined(__GNUC__) && !defined(__CUDA_ARCH__)
    double y;
    __asm__("fsqrt %d0, %d1" : "=w"(y) : "w"(x));
    return y;
#else
    return sqrt(x);
#endif
}

/* Returns the squared distance of two points, rounded. */
PBW__INLINE double pbw__squared(const double *p, const double *q, int dim)
{
    const double x = p[0] - q[0], y = p[1] - q[1], z = dim == 3 ? p[2] - q[2] : 0.0;
    return x * x + y * y + z * z;
}

/* Hash of count doubles, going on from another; equal for -0.0 and 0.0 in every floating-point mode. */
PBW__INLINE uint64_t pbw__hash_doubles(uint64_t hash, const double *x, int count)
{
    int k;
    for (k = 0; k < count; k++) {
        uint64_t bits;
        memcpy(&bits, x + k, sizeof(bits));
        hash = pbw_mix(hash + UINT64_C(0x9e3779b97f4a7c15) + (bits << 1 == 0 ? 0 : bits));
    }
    return hash;
}

/* Returns the first entry for a key in a hash table; size: a power of two. */
PBW__INLINE size_t pbw__hash_entry(uint64_t key, size_t size)
{
    return (size_t)(key * UINT64_C(0x9e3779b97f4a7c15) >> 32) & (size - 1);
}

/* What we call of Windows.  windows.h would leave its macros behind, so we declare it as that does, which may still
   follow.  Where it came first it has declared all, but not for a target before Windows 7. */
#ifdef _WIN32
union _LARGE_INTEGER;
struct _RTL_SRWLOCK;
struct _RTL_CONDITION_VARIABLE;
#if !defined(_WINDOWS_) || (defined(_WIN32_WINNT) && _WIN32_WINNT < 0x0601)
#ifdef __cplusplus
extern "C" {
#endif
#define PBW__WIN32(result) extern __declspec(dllimport) result __stdcall
PBW__WIN32(int) QueryPerformanceCounter(union _LARGE_INTEGER *count);
PBW__WIN32(int) QueryPerformanceFrequency(union _LARGE_INTEGER *frequency);
PBW__WIN32(unsigned long) WaitForSingleObject(void *thread, unsigned long milliseconds);
PBW__WIN32(int) CloseHandle(void *thread);
PBW__WIN32(unsigned long) GetCurrentThreadId(void);
PBW__WIN32(unsigned long) GetActiveProcessorCount(unsigned short group);
PBW__WIN32(void) AcquireSRWLockExclusive(struct _RTL_SRWLOCK *mutex);
PBW__WIN32(void) ReleaseSRWLockExclusive(struct _RTL_SRWLOCK *mutex);
PBW__WIN32(void) WakeConditionVariable(struct _RTL_CONDITION_VARIABLE *condition);
PBW__WIN32(void) WakeAllConditionVariable(struct _RTL_CONDITION_VARIABLE *condition);
PBW__WIN32(int) SleepConditionVariableSRW(struct _RTL_CONDITION_VARIABLE *condition, struct _RTL_SRWLOCK *mutex,
                                          unsigned long milliseconds, unsigned long flags);
#ifdef __cplusplus
}
#endif
#endif
/* Reads a clock that nobody sets: for statistics, progress, short waits. */
static double pbw__seconds(void)
{
    int64_t count = 0, frequency = 1;
    (void)QueryPerformanceCounter((union _LARGE_INTEGER *)(void *)&count);
    (void)QueryPerformanceFrequency((union _LARGE_INTEGER *)(void *)&frequency);
    return (double)count / (double)frequency;
}
#else
#if defined(CLOCK_MONOTONIC)
#define PBW__CLOCK CLOCK_MONOTONIC
#elif !defined(__cplusplus) && (defined(__EMSCRIPTEN__) || (defined(__linux__) && defined(__LP64__)))
#define PBW__CLOCK 1                                 /* strict C modes hide it, and what takes it */
extern int clock_gettime(int clock, struct timespec *now);
#ifdef PBW__THREADS
extern int pthread_condattr_setclock(pthread_condattr_t *attributes, int clock);
#endif
#endif
static double pbw__seconds(void)                     /* as above, where there is such a clock */
{
#ifdef PBW__CLOCK
    struct timespec now;
    clock_gettime(PBW__CLOCK, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
#else
    struct timeval now;
    gettimeofday(&now, NULL);
    return (double)now.tv_sec + 1e-6 * (double)now.tv_usec;
#endif
}
#endif

/* The rounding mode, flush-to-zero and denormals-are-zero bits of this thread.  A program linked with -ffast-math
   starts with them set, whatever we were compiled with, so we set what we need and put it back. */
typedef uint64_t pbw__fp;

static pbw__fp pbw__fp_enter(void)
{
    pbw__fp fp = 0;
#if defined(__SSE2__)
    fp = _mm_getcsr();
    _mm_setcsr(((unsigned)fp | 0x1f80u) & ~0xe040u);         /* exceptions masked; round to nearest; no FTZ, no DAZ */
#elif defined(__aarch64__) && defined(__GNUC__)
    __asm__ __volatile__("mrs %0, fpcr" : "=r"(fp));
    __asm__ __volatile__("msr fpcr, %0" : : "r"(fp & ~(uint64_t)0x01c09f00) : "memory");
#endif
    return fp;
}

static void pbw__fp_leave(pbw__fp fp)
{
#if defined(__SSE2__)
    _mm_setcsr((unsigned)fp);
#elif defined(__aarch64__) && defined(__GNUC__)
    __asm__ __volatile__("msr fpcr, %0" : : "r"(fp) : "memory");
#else
    (void)fp;
#endif
}

/* Returns whether identities of IEEE double arithmetic, to nearest even and with denormals, hold: each line fails in
   one of the modes that it names.  Clang has no macro for parts of -ffast-math, so these tests find them too: the
   compiler cannot know what it reads from volatiles. */
static int pbw__fp_is_exact(void)
{
    volatile double given[] = { 1.0, PBW__EPSILON, DBL_MIN, 9007199254740991.0, 3.0, 5.0, -0.0, HUGE_VAL };
    double one = given[0], u = given[1], tiny = given[2], big = given[3], three = given[4], five = given[5];
    double zero = given[6], infinite = given[7], half = 0.5 * tiny, some = one / three, more = five / three;
    return one + u == one && one - 0.5 * u == one            /* rounding other than to nearest even */
        && (one + 2 * u) + u == one + 4 * u && -one - u == -one
        && half > 0.0 && half * 2.0 == tiny                  /* flushed denormals */
        && (big + 2.0) - big == one                          /* reassociation, excess precision, float constants */
        && some == 1.0 / 3.0 && more == 5.0 / 3.0            /* products with reciprocals */
        && some * three - one == 0.0                         /* fused operations: clang's fast overrides our pragma */
        && one / (zero + 0.0) > 0.0                          /* zeros without a sign */
        && !(infinite - infinite == 0.0);                    /* finite numbers only */
}

/* The system's threads: pthreads, or those of Win32. */
#if defined(PBW__THREADS) && defined(_WIN32)
typedef void *pbw__thread, *pbw__mutex, *pbw__condition;     /* the last two hold NULL at first */
typedef unsigned long pbw__thread_id;
typedef unsigned pbw__thread_result;
typedef pbw__thread_result (__stdcall pbw__thread_body)(void *arg);
#define PBW__SRWLOCK(mutex) ((struct _RTL_SRWLOCK *)(void *)(mutex))
#define PBW__VARIABLE(condition) ((struct _RTL_CONDITION_VARIABLE *)(void *)(condition))
#define PBW__FOREVER 0xffffffffu
#define PBW__THREAD_CALL __stdcall
#define PBW__CORES() ((long)GetActiveProcessorCount(0xffff))            /* of all groups of processors */
#define PBW__THIS_THREAD() GetCurrentThreadId()
#define PBW__SAME_THREAD(a, b) ((a) == (b))
#define PBW__THREAD_JOIN(thread) \
    ((void)WaitForSingleObject(thread, PBW__FOREVER), (void)CloseHandle(thread))
#define PBW__MUTEX_INIT(mutex) ((void)(mutex))
#define PBW__MUTEX_DESTROY(mutex) ((void)(mutex))
#define PBW__LOCK(mutex) AcquireSRWLockExclusive(PBW__SRWLOCK(mutex))
#define PBW__UNLOCK(mutex) ReleaseSRWLockExclusive(PBW__SRWLOCK(mutex))
#define PBW__CONDITION_INIT(condition) ((void)(condition))
#define PBW__CONDITION_DESTROY(condition) ((void)(condition))
#define PBW__WAKE(condition) WakeConditionVariable(PBW__VARIABLE(condition))
#define PBW__WAKE_ALL(condition) WakeAllConditionVariable(PBW__VARIABLE(condition))
#define PBW__SLEEP(condition, mutex, milliseconds) \
    ((void)SleepConditionVariableSRW(PBW__VARIABLE(condition), PBW__SRWLOCK(mutex), milliseconds, 0))
#define PBW__WAIT(condition, mutex) PBW__SLEEP(condition, mutex, PBW__FOREVER)
#define PBW__WAIT_50MS(condition, mutex) PBW__SLEEP(condition, mutex, 50)

static int pbw__thread_start(pbw__thread *thread, unsigned stack, pbw__thread_body *body, void *arg)
{
    *thread = (pbw__thread)_beginthreadex(NULL, stack, body, arg, 0x10000, NULL);      /* stack: to reserve */
    return *thread != NULL;
}
#elif defined(PBW__THREADS)
typedef pthread_t pbw__thread, pbw__thread_id;
typedef pthread_mutex_t pbw__mutex;
typedef pthread_cond_t pbw__condition;
typedef void *pbw__thread_result;
typedef pbw__thread_result (pbw__thread_body)(void *arg);
#define PBW__THREAD_CALL
#define PBW__CORES() sysconf(_SC_NPROCESSORS_ONLN)
#define PBW__THIS_THREAD() pthread_self()
#define PBW__SAME_THREAD(a, b) pthread_equal(a, b)
#define PBW__THREAD_JOIN(thread) pthread_join(thread, NULL)
#define PBW__MUTEX_INIT(mutex) pthread_mutex_init(mutex, NULL)
#define PBW__MUTEX_DESTROY(mutex) pthread_mutex_destroy(mutex)
#define PBW__LOCK(mutex) pthread_mutex_lock(mutex)
#define PBW__UNLOCK(mutex) pthread_mutex_unlock(mutex)
#define PBW__CONDITION_INIT(condition) pbw__condition_init(condition)
#define PBW__CONDITION_DESTROY(condition) pthread_cond_destroy(condition)
#define PBW__WAKE(condition) pthread_cond_signal(condition)
#define PBW__WAKE_ALL(condition) pthread_cond_broadcast(condition)
#define PBW__WAIT(condition, mutex) pthread_cond_wait(condition, mutex)
#define PBW__WAIT_50MS(condition, mutex) pbw__wait_50ms(condition, mutex)

static int pbw__thread_start(pbw__thread *thread, size_t stack, pbw__thread_body *body, void *arg)
{
    pthread_attr_t attributes;
    int failed;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, stack);
    failed = pthread_create(thread, &attributes, body, arg);
    pthread_attr_destroy(&attributes);
    return !failed;
}

static void pbw__condition_init(pbw__condition *condition)
{
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
#if defined(PBW__CLOCK) && !defined(__APPLE__)
    pthread_condattr_setclock(&attributes, PBW__CLOCK);
#endif
    pthread_cond_init(condition, &attributes);
    pthread_condattr_destroy(&attributes);
}

static void pbw__wait_50ms(pbw__condition *condition, pbw__mutex *mutex)
{
#ifdef __APPLE__
    const struct timespec wait = { 0, 50000000 };
    pthread_cond_timedwait_relative_np(condition, mutex, &wait);
#else
    const double end = pbw__seconds() + 0.05;
    struct timespec until;
    until.tv_sec = (time_t)end;
    until.tv_nsec = (long)((end - (double)until.tv_sec) * 1e9);
    pthread_cond_timedwait(condition, mutex, &until);
#endif
}
#endif
/* ------------------------------------------------------------------------------------------------------
   >>lanes        Four numbers at once.
   In: AVX2 or NEON.  Out: vector types, and one function for each operation on them that the rooms below need.

   A vector has four doubles or four 32-bit integers, in lanes 0 to 3, or two doubles.  + - * == | << work lane by
   lane.  A mask has all bits of a lane set, or none.  A set of lanes is a number with bit i for lane i.  NaNs arise
   only after overflow, where the error bounds are infinite anyway: pbw__max4, pbw__max_lane and pbw__min_lane may
   drop them.
   On x86 the functions that use vectors are called only if the processor has AVX2.  Every 64-bit Arm has NEON.
   PBW_NO_SIMD leaves only the scalar code, which gives the same answers.

   There is no path for AVX-512: eight lanes, two simplices of a cavity, gain 1 to 3 % for 170 lines; four lanes with
   its registers and masks gain 0 to 2 %, or lose.
   ------------------------------------------------------------------------------------------------------ */
#ifdef PBW__SIMD
#define PBW__SIMD_INLINE static inline PBW__SIMD __attribute__((always_inline, unused))
#ifdef PBW__NEON
#define PBW__BY_ISA(avx2, neon) neon
#define PBW__HALVES2(f, a, b) pbw__join(f(pbw__half(a, 0), pbw__half(b, 0)), f(pbw__half(a, 1), pbw__half(b, 1)))
#define PBW__HALF3(f, a, b, c, i) f(pbw__half(a, i), pbw__half(b, i), pbw__half(c, i))
#define PBW__HALVES3(f, a, b, c) pbw__join(PBW__HALF3(f, a, b, c, 0), PBW__HALF3(f, a, b, c, 1))
typedef float64x2_t pbw__d2;
typedef double pbw__d4 __attribute__((vector_size(32), aligned(16)));      /* the compiler splits sums, products */
typedef int64_t pbw__l4 __attribute__((vector_size(32), aligned(16)));     /* and bitwise operations */
typedef union pbw__halves { pbw__d4 whole; pbw__d2 half[2]; } pbw__halves;
#else
#define PBW__BY_ISA(avx2, neon) avx2
typedef __m128d pbw__d2;
typedef __m256d pbw__d4;
typedef __m256i pbw__l4;
#endif
typedef int32_t pbw__i4 __attribute__((vector_size(16)));

PBW__INLINE int pbw__simd_works(void)
{
    return PBW__BY_ISA(__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")
                       && __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt"), 1);
}

/* Defines a function that returns the expression avx2 or neon. */
#define PBW__OPERATION(type, name, parameters, avx2, neon) \
    PBW__SIMD_INLINE type name parameters \
    { \
        return PBW__BY_ISA(avx2, neon); \
    }

#ifdef PBW__NEON
PBW__SIMD_INLINE pbw__d2 pbw__half(pbw__d4 x, int i)
{
    pbw__halves halves;
    halves.whole = x;
    return halves.half[i];
}

PBW__SIMD_INLINE pbw__d4 pbw__join(pbw__d2 low, pbw__d2 high)
{
    pbw__halves halves;
    halves.half[0] = low;
    halves.half[1] = high;
    return halves.whole;
}

#define PBW__BLEND2(x, y, mask) vbslq_f64((uint64x2_t)(mask), y, x)
#endif

/* Permute four doubles, four integers: the result has lanes i, j, k, l (constants) of x. */
#ifdef PBW__AVX2
#define PBW__PICK(x, i, j, k, l) _mm256_permute4x64_pd(x, (i) | (j) << 2 | (k) << 4 | (l) << 6)
#define PBW__PICK4(x, i, j, k, l) ((pbw__i4)_mm_shuffle_epi32((__m128i)(x), (i) | (j) << 2 | (k) << 4 | (l) << 6))
#else
#define PBW__PICK(x, i, j, k, l) pbw__four((x)[i], (x)[j], (x)[k], (x)[l])
#define PBW__PICK4(x, i, j, k, l) pbw__four_i((x)[i], (x)[j], (x)[k], (x)[l])

PBW__SIMD_INLINE pbw__i4 pbw__four_i(int32_t a, int32_t b, int32_t c, int32_t d)
{
    const pbw__i4 lanes = { a, b, c, d };
    return lanes;
}
#endif

PBW__OPERATION(pbw__d4, pbw__splat, (double x),     /* x in each lane */
    _mm256_set1_pd(x), pbw__join(vdupq_n_f64(x), vdupq_n_f64(x)))

PBW__OPERATION(pbw__d4, pbw__four, (double a, double b, double c, double d),
    _mm256_set_pd(d, c, b, a),
    pbw__join(vzip1q_f64(vdupq_n_f64(a), vdupq_n_f64(b)), vzip1q_f64(vdupq_n_f64(c), vdupq_n_f64(d))))
PBW__OPERATION(double, pbw__first, (pbw__d4 x),     /* lane 0 */
    _mm256_cvtsd_f64(x), vgetq_lane_f64(pbw__half(x, 0), 0))

/* Loads two entries of each of four records: the first ones into *x, the second ones into *y. */
PBW__SIMD_INLINE void pbw__columns(const double *a, const double *b, const double *c, const double *d, pbw__d4 *x,
                                   pbw__d4 *y)
{
#ifdef PBW__AVX2
    const pbw__d4 ac = _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(a)), _mm_loadu_pd(c), 1);
    const pbw__d4 bd = _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(b)), _mm_loadu_pd(d), 1);
    *x = _mm256_unpacklo_pd(ac, bd);
    *y = _mm256_unpackhi_pd(ac, bd);
#else
    const pbw__d2 a2 = vld1q_f64(a), b2 = vld1q_f64(b), c2 = vld1q_f64(c), d2 = vld1q_f64(d);
    *x = pbw__join(vzip1q_f64(a2, b2), vzip1q_f64(c2, d2));
    *y = pbw__join(vzip2q_f64(a2, b2), vzip2q_f64(c2, d2));
#endif
}

PBW__OPERATION(pbw__d4, pbw__fma, (pbw__d4 a, pbw__d4 b, pbw__d4 c),     /* a b + c, rounded once */
    _mm256_fmadd_pd(a, b, c), PBW__HALVES3(vfmaq_f64, c, a, b))
PBW__OPERATION(pbw__d4, pbw__fnma, (pbw__d4 a, pbw__d4 b, pbw__d4 c),     /* c - a b */
    _mm256_fnmadd_pd(a, b, c), PBW__HALVES3(vfmsq_f64, c, a, b))
/* Returns a d - b c; one product is rounded, the other fused into the difference. */
PBW__OPERATION(pbw__d4, pbw__det2, (pbw__d4 a, pbw__d4 b, pbw__d4 c, pbw__d4 d),
    _mm256_fmsub_pd(a, d, b * c), pbw__fnma(b, c, a * d))
PBW__OPERATION(pbw__d4, pbw__max4, (pbw__d4 a, pbw__d4 b), _mm256_max_pd(a, b), PBW__HALVES2(vmaxq_f64, a, b))
PBW__OPERATION(pbw__d4, pbw__min4, (pbw__d4 a, pbw__d4 b), _mm256_min_pd(a, b), PBW__HALVES2(vminq_f64, a, b))
PBW__OPERATION(pbw__d4, pbw__abs4, (pbw__d4 x),
    _mm256_andnot_pd(_mm256_set1_pd(-0.0), x), pbw__join(vabsq_f64(pbw__half(x, 0)), vabsq_f64(pbw__half(x, 1))))

/* Return the largest lane, the smallest lane and the sum of the lanes, each broadcast to all lanes. */
#define PBW__NEXT(f, x) f(x, _mm256_permute_pd(x, 5))
#define PBW__ACROSS(name, f, pair, all) \
    PBW__OPERATION(pbw__d4, name, (pbw__d4 x), \
        f(PBW__NEXT(f, x), PBW__PICK(PBW__NEXT(f, x), 2, 3, 0, 1)), \
        pbw__splat(all(pair(pbw__half(x, 0), pbw__half(x, 1)))))
PBW__ACROSS(pbw__max_lane, _mm256_max_pd, vmaxq_f64, vmaxvq_f64)
PBW__ACROSS(pbw__min_lane, _mm256_min_pd, vminq_f64, vminvq_f64)
PBW__ACROSS(pbw__sum_lanes, _mm256_add_pd, vpaddq_f64, vaddvq_f64)

/* A permutation of four doubles: lane i of the result is lane lanes[i], modulo 4, of the argument. */
#ifdef PBW__AVX2
typedef __m256i pbw__order4;
#else
typedef struct pbw__order4 { uint8x16_t low, high; } pbw__order4;
#endif

PBW__SIMD_INLINE pbw__order4 pbw__order4_of(pbw__i4 lanes)
{
#ifdef PBW__AVX2
    const __m256i halves = _mm256_shuffle_epi32(_mm256_cvtepi32_epi64((__m128i)(lanes + lanes)), 0xa0);
    return _mm256_add_epi32(halves, _mm256_setr_epi32(0, 1, 0, 1, 0, 1, 0, 1));
#else
    const uint8x16_t first = { 0, 0, 0, 0, 0, 0, 0, 0, 4, 4, 4, 4, 4, 4, 4, 4 };
    const uint8x16_t byte = { 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7 };
    const uint8x16_t from = vshlq_n_u8((uint8x16_t)vandq_s32(lanes, vdupq_n_s32(3)), 3);
    pbw__order4 order;
    order.low = vorrq_u8(vqtbl1q_u8(from, first), byte);
    order.high = vorrq_u8(vqtbl1q_u8(from, vorrq_u8(first, vdupq_n_u8(8))), byte);
    return order;
#endif
}

PBW__SIMD_INLINE pbw__d4 pbw__reorder(pbw__d4 x, pbw__order4 order)
{
#ifdef PBW__AVX2
    return _mm256_castps_pd(_mm256_permutevar8x32_ps(_mm256_castpd_ps(x), order));
#else
    uint8x16x2_t bytes;
    bytes.val[0] = (uint8x16_t)pbw__half(x, 0);
    bytes.val[1] = (uint8x16_t)pbw__half(x, 1);
    return pbw__join((pbw__d2)vqtbl2q_u8(bytes, order.low), (pbw__d2)vqtbl2q_u8(bytes, order.high));
#endif
}

PBW__OPERATION(pbw__d4, pbw__load4d, (const double *from),
    _mm256_loadu_pd(from), pbw__join(vld1q_f64(from), vld1q_f64(from + 2)))

PBW__OPERATION(pbw__d4, pbw__drop_last, (pbw__d4 x),     /* zero in lane 3 */
    _mm256_blend_pd(x, _mm256_setzero_pd(), 8), pbw__join(pbw__half(x, 0), vsetq_lane_f64(0.0, pbw__half(x, 1), 1)))

/* Masks. */
PBW__OPERATION(pbw__d4, pbw__greater, (pbw__d4 a, pbw__d4 b),
    _mm256_cmp_pd(a, b, _CMP_GT_OQ), PBW__HALVES2((pbw__d2)vcgtq_f64, a, b))
PBW__OPERATION(pbw__d4, pbw__at_least, (pbw__d4 a, pbw__d4 b),
    _mm256_cmp_pd(a, b, _CMP_GE_OQ), PBW__HALVES2((pbw__d2)vcgeq_f64, a, b))
PBW__OPERATION(pbw__d4, pbw__equal, (pbw__d4 a, pbw__d4 b),
    _mm256_cmp_pd(a, b, _CMP_EQ_OQ), PBW__HALVES2((pbw__d2)vceqq_f64, a, b))
PBW__OPERATION(pbw__d4, pbw__mask, (const int64_t *from),
    _mm256_castsi256_pd(_mm256_loadu_si256((const __m256i *)(const void *)from)),
    pbw__join((pbw__d2)vld1q_s64(from), (pbw__d2)vld1q_s64(from + 2)))

PBW__OPERATION(pbw__d4, pbw__blend, (pbw__d4 x, pbw__d4 y, pbw__d4 mask),     /* y in the lanes of the mask */
    _mm256_blendv_pd(x, y, mask), PBW__HALVES3(PBW__BLEND2, x, y, mask))
PBW__OPERATION(pbw__d4, pbw__and4, (pbw__d4 mask, pbw__d4 x),     /* x, zero in other lanes */
    _mm256_and_pd(mask, x), (pbw__d4)((pbw__l4)mask & (pbw__l4)x))
PBW__OPERATION(pbw__d4, pbw__andnot4, (pbw__d4 mask, pbw__d4 x),     /* x, zero in the lanes of the mask */
    _mm256_andnot_pd(mask, x), (pbw__d4)(~(pbw__l4)mask & (pbw__l4)x))
PBW__OPERATION(pbw__d4, pbw__or4, (pbw__d4 mask, pbw__d4 other),
    _mm256_or_pd(mask, other), (pbw__d4)((pbw__l4)mask | (pbw__l4)other))
PBW__OPERATION(pbw__d4, pbw__blend_zero, (pbw__d4 x, pbw__d4 mask, pbw__d4 y),   /* y in masked lanes, where x is 0 */
    _mm256_or_pd(x, _mm256_and_pd(mask, y)), pbw__blend(x, y, mask))

PBW__SIMD_INLINE unsigned pbw__signs(pbw__d4 x)      /* the set of negative lanes, -0.0 too */
{
#ifdef PBW__AVX2
    return (unsigned)_mm256_movemask_pd(x);
#else
    const int32x4_t place = { 0, 1, 2, 3 };
    const uint32x4_t high = vuzp2q_u32((uint32x4_t)pbw__half(x, 0), (uint32x4_t)pbw__half(x, 1));
    return vaddvq_u32(vshlq_u32(vshrq_n_u32(high, 31), place));
#endif
}

/* Return the number of lanes in a set; the set of the first `count` lanes, of all four if count is larger. */
PBW__OPERATION(unsigned, pbw__count4, (unsigned set),
    (unsigned)__builtin_popcount(set), (unsigned)(0x4332322132212110u >> 4 * set) & 15)
PBW__OPERATION(unsigned, pbw__first_lanes, (unsigned count), _bzhi_u32(15, count), count < 4 ? (1u << count) - 1 : 15)

/* Pair k is bit k of `first` below bit k of `second`.  Returns those of the pairs 0, 1, 2 that are in the set
   `chosen`, packed. */
PBW__SIMD_INLINE unsigned pbw__pairs_of(unsigned first, unsigned second, unsigned chosen)
{
#ifdef PBW__AVX2
    return _pext_u32(_pdep_u32(first, 0x15) | _pdep_u32(second, 0x2a), 3 * _pdep_u32(chosen, 0x15));
#else
    unsigned set = 0, k;
    for (k = 3; k-- > 0; ) {
        unsigned take = chosen >> k & 1;
        set = set << 2 * take | ((first >> k & 1) | (second >> k & 1) << 1) * take;
    }
    return set;
#endif
}

/* Two doubles. */
PBW__OPERATION(pbw__d2, pbw__load2, (const double *from), _mm_loadu_pd(from), vld1q_f64(from))
PBW__OPERATION(pbw__d2, pbw__turn_right, (pbw__d2 x),     /* (y, -x) */
    _mm_xor_pd(_mm_shuffle_pd(x, x, 1), _mm_set_pd(-0.0, 0.0)),
    vcopyq_laneq_f64(vextq_f64(x, x, 1), 1, vnegq_f64(x), 0))

PBW__OPERATION(unsigned, pbw__signs2, (pbw__d2 x, pbw__d2 y),     /* of x[0] + x[1] and y[0] + y[1] */
    (unsigned)_mm_movemask_pd(_mm_hadd_pd(x, y)),
    (unsigned)(((uint64x2_t)vpaddq_f64(x, y))[0] >> 63 | ((uint64x2_t)vpaddq_f64(x, y))[1] >> 63 << 1))

/* Four integers, from and to arrays of any type. */
PBW__OPERATION(pbw__i4, pbw__load4, (const void *from),
    (pbw__i4)_mm_loadu_si128((const __m128i *)from), (pbw__i4)vld1q_u8((const unsigned char *)from))

PBW__SIMD_INLINE void pbw__store4(void *to, pbw__i4 x)
{
    PBW__BY_ISA(_mm_storeu_si128((__m128i *)to, (__m128i)x), vst1q_u8((unsigned char *)to, (uint8x16_t)x));
}

PBW__OPERATION(pbw__i4, pbw__splat_i, (int32_t x),     /* x in each lane */
    (pbw__i4)_mm_set1_epi32(x), vdupq_n_s32(x))
PBW__OPERATION(pbw__i4, pbw__lead, (pbw__i4 x, pbw__i4 y),     /* y in lane 0 */
    (pbw__i4)_mm_blend_epi32((__m128i)x, (__m128i)y, 1), vcopyq_laneq_s32(x, 0, y, 0))
PBW__OPERATION(pbw__i4, pbw__shuffle4, (pbw__i4 x, const unsigned char *bytes),     /* byte i: bytes[i] of x */
    (pbw__i4)_mm_shuffle_epi8((__m128i)x, (__m128i)pbw__load4(bytes)),
    (pbw__i4)vqtbl1q_u8((uint8x16_t)x, vld1q_u8(bytes)))

PBW__OPERATION(pbw__i4, pbw__permute4, (pbw__i4 x, pbw__i4 lanes),     /* lanes of x, by numbers modulo 4 */
    (pbw__i4)_mm_permutevar_ps((__m128)x, (__m128i)lanes),
    (pbw__i4)vqtbl1q_u8((uint8x16_t)x, (uint8x16_t)((lanes & 3) * 0x04040404 + 0x03020100)))

PBW__SIMD_INLINE uint32_t pbw__apart4(pbw__i4 x, pbw__i4 y)        /* the sum of |x - y| over the lanes */
{
#ifdef PBW__NEON
    return vaddvq_u32(vreinterpretq_u32_s32(vabdq_s32((int32x4_t)x, (int32x4_t)y)));
#else
    pbw__i4 apart = (pbw__i4)_mm_abs_epi32((__m128i)(x - y));
    apart += PBW__PICK4(apart, 2, 3, 0, 1);
    apart += PBW__PICK4(apart, 1, 0, 3, 2);
    return (uint32_t)_mm_cvtsi128_si32((__m128i)apart);
#endif
}

PBW__OPERATION(pbw__i4, pbw__dot_pairs, (pbw__i4 x, int low, int high),     /* low * lower + high * upper half */
    (pbw__i4)_mm_madd_epi16((__m128i)x, _mm_set1_epi32(high * 65536 + low)), (x & 0xffff) * low + (x >> 16) * high)

/* The pair arithmetic of >>predicates in four lanes; fused operations are always available here. */
typedef struct pbw__pair4 { pbw__d4 head, tail; } pbw__pair4;

PBW__SIMD_INLINE pbw__pair4 pbw__plus4(pbw__pair4 a, pbw__pair4 b)
{
    pbw__d4 head = a.head + b.head, other = head - a.head;
    pbw__pair4 result = { head, ((a.head - (head - other)) + (b.head - other)) + (a.tail + b.tail) };
    return result;
}

PBW__SIMD_INLINE pbw__pair4 pbw__minus4(pbw__pair4 a, pbw__pair4 b)
{
    pbw__d4 head = a.head - b.head, other = head - a.head;
    pbw__pair4 result = { head, ((a.head - (head - other)) - (b.head + other)) + (a.tail - b.tail) };
    return result;
}

PBW__SIMD_INLINE pbw__pair4 pbw__times4(pbw__pair4 a, pbw__pair4 b)
{
    pbw__d4 head = pbw__fma(a.head, b.head, pbw__splat(0.0));    /* a plain product could be fused into a sum */
    pbw__d4 error = pbw__fma(a.head, b.head, -head);
    pbw__pair4 result = { head, pbw__fma(a.head, b.tail, pbw__fma(a.tail, b.head, error)) };
    return result;
}

/* a0 b1 - a1 b0 */
PBW__SIMD_INLINE pbw__pair4 pbw__cross4(pbw__pair4 a0, pbw__pair4 a1, pbw__pair4 b0, pbw__pair4 b1)
{
    return pbw__minus4(pbw__times4(a0, b1), pbw__times4(a1, b0));
}

/* a0 b0 - a1 b1 + a2 b2 */
PBW__SIMD_INLINE pbw__pair4 pbw__sum4(pbw__pair4 a0, pbw__pair4 b0, pbw__pair4 a1, pbw__pair4 b1, pbw__pair4 a2,
                                      pbw__pair4 b2)
{
    return pbw__plus4(pbw__minus4(pbw__times4(a0, b0), pbw__times4(a1, b1)), pbw__times4(a2, b2));
}

/* Returns a - b, zero in masked lanes. */
PBW__SIMD_INLINE pbw__pair4 pbw__difference4(pbw__d4 a, pbw__d4 b, pbw__d4 mask)
{
    pbw__pair4 x = { a, pbw__splat(0.0) }, y = { b, pbw__splat(0.0) };
    x = pbw__minus4(x, y);
    x.head = pbw__andnot4(mask, x.head);
    x.tail = pbw__andnot4(mask, x.tail);
    return x;
}
#endif
/* ------------------------------------------------------------------------------------------------------
   >>memory       One call's memory: the one allocator hook, the bytes allocated through it, pages.
   In: options.resize or NULL, options.memory_limit.  Out: blocks, or NULL for out of memory or over the limit.
   Holds: used = sum of the sizes of live blocks <= peak; with a limit, peak <= limit.
   ------------------------------------------------------------------------------------------------------ */
static void *pbw__default_resize(void *user, void *ptr, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        free(ptr);
        return NULL;
    }
    return realloc(ptr, new_size);
}

#define PBW__LARGE ((size_t)1 << 20)                 /* bytes of a block that is worth the system's advice */

/* MADV_HUGEPAGE on a large block, rounded outwards to pages: rounded inwards it would split the mapping, and realloc
   could no longer move it by mremap.  Advice only: it may fail.  A block of the caller's allocator gets none. */
static void pbw__advise(const pbw_memory *memory, void *start, size_t bytes)
{
#ifdef __linux__
    const size_t page = 4096, skip = (size_t)(uintptr_t)start % page;
    if (bytes >= PBW__LARGE && memory->resize == pbw__default_resize) {
        (void)madvise((char *)start - skip, (skip + bytes + page - 1) / page * page, 14);        /* MADV_HUGEPAGE */
    }
#else
    (void)memory;
    (void)start;
    (void)bytes;
#endif
}

PBWDEF void pbw_memory_start(pbw_memory *memory, const pbw_options *options)
{
    memset(memory, 0, sizeof(*memory));
    memory->resize = options != NULL && options->resize != NULL ? options->resize : pbw__default_resize;
    memory->user = options != NULL ? options->resize_user : NULL;
    memory->limit = options != NULL ? options->memory_limit : 0;
}

PBWDEF size_t pbw_memory_left(const pbw_memory *memory)
{
    const size_t used = PBW__LOAD(&memory->used);
    return memory->limit == 0 ? 0 : used < memory->limit ? memory->limit - used : 1;
}

PBWDEF void *pbw_memory_resize(pbw_memory *memory, void *ptr, size_t old_count, size_t count, size_t size)
{
    size_t old_bytes = old_count * size, bytes, grown = 0, used = 0;
    void *block;
    if (count > (size_t)-1 / 2 / size || (count == 0 && ptr == NULL)) {
        return NULL;
    }
    bytes = count * size;
    if (bytes > old_bytes) {                         /* counted before it is allocated, until after it is freed */
        grown = bytes - old_bytes;
        used = PBW__ADD(&memory->used, grown) + grown;
        if (memory->limit != 0 && used > memory->limit) {
            (void)PBW__ADD(&memory->used, (size_t)0 - grown);
            return NULL;
        }
    }
    block = memory->resize(memory->user, ptr, old_bytes, bytes);
    if (block == NULL && bytes != 0) {
        (void)PBW__ADD(&memory->used, (size_t)0 - grown);
    } else if (grown == 0) {
        (void)PBW__ADD(&memory->used, bytes - old_bytes);        /* wraps around */
    } else {
        pbw_atomic_max(&memory->peak, used);
        pbw__advise(memory, block, bytes);
    }
    return block;
}

static void *pbw__nested_resize(void *user, void *ptr, size_t old_size, size_t new_size)
{
    return pbw_memory_resize((pbw_memory *)user, ptr, old_size, new_size, 1);
}

PBWDEF void pbw_memory_nest(pbw_memory *memory, pbw_options *options)
{
    const int own = memory->limit == 0 && memory->resize == pbw__default_resize;
    options->resize = memory->limit != 0 ? pbw__nested_resize : own ? NULL : memory->resize;
    options->resize_user = memory->limit != 0 ? memory : memory->user;
    options->memory_limit = 0;
}

static void *pbw__allocate(pbw_memory *memory, size_t count, size_t size)
{
    return pbw_memory_resize(memory, NULL, 0, count == 0 ? 1 : count, size);
}

static void pbw__release(pbw_memory *memory, void *ptr, size_t count, size_t size)
{
    if (ptr != NULL) {
        (void)pbw_memory_resize(memory, ptr, count == 0 ? 1 : count, 0, size);
    }
}

PBWDEF int pbw_memory_fit(pbw_memory *memory, void *array, size_t *capacity, size_t wanted, size_t size)
{
    void *old, *block;
    if (wanted == *capacity) {
        return 1;
    }
    memcpy(&old, array, sizeof(old));
    block = pbw_memory_resize(memory, old, *capacity, wanted, size);
    if (block == NULL && wanted != 0) {
        return 0;
    }
    memcpy(array, &block, sizeof(block));
    *capacity = wanted;
    return 1;
}

PBWDEF int pbw_memory_grow(pbw_memory *memory, void *array, size_t *capacity, size_t count, size_t more, size_t size)
{
    const size_t need = count + more, larger = *capacity + *capacity / 4 + 16;
    return need >= count
        && (need <= *capacity || pbw_memory_fit(memory, array, capacity, need > larger ? need : larger, size));
}

PBWDEF int pbw_memory_zeros(pbw_memory *memory, void *array, size_t *capacity, size_t wanted, size_t size)
{
    void *items;
    if (!pbw_memory_fit(memory, array, capacity, wanted == 0 ? 1 : wanted, size)) {
        return 0;
    }
    memcpy(&items, array, sizeof(items));
    memset(items, 0, *capacity * size);
    return 1;
}

/* Resize and release the array x, a member of `owner` beside its size x_capacity. */
#define PBW__RESIZE(memory, owner, x, wanted) \
    pbw_memory_fit(memory, &(owner)->x, &(owner)->x##_capacity, wanted, sizeof(*(owner)->x))
#define PBW__RELEASE(memory, owner, x) pbw__release(memory, (owner)->x, (owner)->x##_capacity, sizeof(*(owner)->x))

/* One call: its memory, progress and threads. */
typedef struct pbw__context {
    pbw_options options;                             /* the caller's, or the defaults */
    pbw_memory memory;
    pbw__fp fp;                                      /* the caller's floating-point state */
    pbw_stage stage;
    double last_report, last_done;
    double reached;                                  /* progress at the end of the last ranged loop of the stage */
    int cancelled;
    int threads;                                     /* that take part, the caller's among them */
#ifdef PBW__THREADS
    pbw__thread_id caller;
    pbw_threads *team;                               /* NULL: not started */
#endif
} pbw__context;

typedef void pbw__task(void *arg, int i);

static void pbw__for(pbw__context *context, int tasks, pbw__task *task, void *arg);      /* these three: >>threads */
static int pbw__report(pbw__context *context, double done);
PBW__INLINE size_t pbw__share(size_t count, int i, int tasks);

/* Commits the pages of large blocks up front, as huge pages where there are any; taking the faults one by one costs
   up to a quarter of a build.  Advice only, as above. */
typedef struct pbw__block { void *start; size_t from, to; } pbw__block;
static pbw__block pbw__block_of(void *start, size_t from, size_t to)
{
    const pbw__block block = { start, from, to };
    return block;
}

typedef struct pbw__pages { char *start; size_t length, huge; } pbw__pages;      /* huge: pages it lies on */
#define PBW__BLOCKS 4                                /* at a time */
#define PBW__HUGE ((size_t)1 << 21)                  /* bytes of a huge page; two tasks at one would both make it */
typedef struct pbw__populating {
    pbw__context *context;
    pbw__pages pages[PBW__BLOCKS];
    size_t huge;                                     /* of all blocks */
    int blocks, tasks;
} pbw__populating;

static void pbw__make_pages(void *arg, int task)
{
#ifdef __linux__
    const pbw__populating *populating = (const pbw__populating *)arg;
    size_t first = pbw__share(populating->huge, task, populating->tasks);
    size_t last = pbw__share(populating->huge, task + 1, populating->tasks);
    int i;
    for (i = 0; i < populating->blocks; i++) {
        const pbw__pages *pages = populating->pages + i;
        const size_t skip = (size_t)(uintptr_t)pages->start % PBW__HUGE;
        size_t from = (first < pages->huge ? first : pages->huge) * PBW__HUGE;
        size_t to = (last < pages->huge ? last : pages->huge) * PBW__HUGE;
        first -= from / PBW__HUGE;                   /* what lies in the next blocks */
        last -= to / PBW__HUGE;
        from = from > skip ? from - skip : 0;
        to = to > skip ? to - skip : 0;              /* small shares may be empty */
        to = to < pages->length ? to : pages->length;
        while (from < to && !pbw__report(populating->context, 0.0)) {
            const size_t most = 2 * PBW__HUGE;       /* 1 ms; where a host has none ready, 10 */
            const size_t step = to - from < most ? to - from : most;
            (void)madvise(pages->start + from, step, 23);        /* MADV_POPULATE_WRITE, since Linux 5.14 */
            from += step;
        }
    }
#else
    (void)arg;
    (void)task;
#endif
}

static void pbw__populate(pbw__context *context, const pbw__block *block, int blocks)
{
    const size_t page = 4096;
    const int most = context->threads > 1 ? 16 * context->threads : 1;       /* pages take times that differ */
    pbw__populating populating;
    populating.context = context;
    populating.huge = 0;
    populating.blocks = 0;
    for (; blocks > 0; block++, blocks--) {
        pbw__pages *pages = populating.pages + populating.blocks;
        const size_t skip = (page - ((size_t)(uintptr_t)block->start + block->from) % page) % page;
        if (block->start == NULL || block->to < PBW__LARGE || block->to - PBW__LARGE < block->from
            || context->memory.resize != pbw__default_resize) {
            continue;
        }
        pages->start = (char *)block->start + block->from + skip;
        pages->length = (block->to - block->from - skip) / page * page;
        pages->huge = ((size_t)(uintptr_t)pages->start % PBW__HUGE + pages->length + PBW__HUGE - 1) / PBW__HUGE;
        populating.huge += pages->huge;
        populating.blocks++;
    }
    populating.tasks = populating.huge < (size_t)most ? (int)populating.huge : most;
    pbw__for(context, populating.tasks, pbw__make_pages, &populating);
}

/* pbw__allocate for arrays of the size of the input. */
static void *pbw__allocate_large(pbw__context *context, size_t count, size_t size)
{
    const pbw__block block = pbw__block_of(pbw__allocate(&context->memory, count, size), 0, count * size);
    pbw__populate(context, &block, 1);
    return block.start;
}
/* ------------------------------------------------------------------------------------------------------
   >>threads      One call's team of threads, tasks and progress.
   In: options.threads, run, progress.  Out: pbw__for, which runs tasks that do not wait on each other, here, on our
   threads or on the caller's; and the caller's answers to progress.
   Holds: between two calls of pbw__for no task runs, and what tasks wrote is seen by all that follows (the team's
   word of work, or the promise of options.run, orders it).  While tasks run, `cancelled` is the only word that one
   thread writes and another reads; it is only ever set, and a stale read only delays the end: relaxed order does.
   ------------------------------------------------------------------------------------------------------ */
/* Hooks for tests.  PBW__TEST_SMALL_SHARES: few points make many tasks; else PBW__SMALLER(items) are the items below
   which another task does not pay.  PBW__TEST_PAUSE(): where a test may delay a thread.
   PBW__TEST_MAY_START(): whether another thread starts. */
#ifdef PBW__TEST_SMALL_SHARES
#define PBW__SMALLER(items) ((items) / 1024 + 1)
#else
#define PBW__SMALLER(items) (items)
#endif
#ifndef PBW__TEST_PAUSE
#define PBW__TEST_PAUSE() ((void)0)
#endif
#ifndef PBW__TEST_MAY_START
#define PBW__TEST_MAY_START() 1
#endif

#define PBW__TICK ((size_t)1 << 16)                  /* items between looks at the clock in streaming loops: < 2 ms */

/* Reports progress if 20 ms have passed, or at the ends of a stage; returns 1 if the caller wants to stop.  Other
   threads only read the cancel flag.  Progress is monotonic; pass 0 if the fraction is unknown. */
static int pbw__report(pbw__context *context, double done)
{
    double now;
    int cancelled = PBW__LOAD(&context->cancelled);
    if (context->options.progress == NULL || cancelled) {
        return cancelled;
    }
#ifdef PBW__THREADS
    if (!PBW__SAME_THREAD(PBW__THIS_THREAD(), context->caller)) {
        return 0;
    }
#endif
    now = pbw__seconds();
    if (now - context->last_report < 0.02 && now >= context->last_report && done < 1.0) {
        return 0;
    }
    context->last_report = now;
    context->last_done = done > context->last_done ? done : context->last_done;      /* tasks come in any order */
    if (context->options.progress(context->options.progress_user, context->stage, context->last_done) != 0) {
        PBW__STORE(&context->cancelled, 1);
        return 1;
    }
    return 0;
}

static int pbw__enter_stage(pbw__context *context, pbw_stage stage)
{
    context->stage = stage;
    context->last_report = -1.0;                     /* the start is reported at once */
    context->last_done = context->reached = 0.0;
    return pbw__report(context, 0.0);
}

/* A task for options.run: any thread may run it, in any floating-point mode. */
typedef struct pbw__guarded { pbw__task *task; void *arg; } pbw__guarded;

static void pbw__run_guarded(void *arg, int i)
{
    const pbw__guarded *guarded = (const pbw__guarded *)arg;
    pbw__fp fp = pbw__fp_enter();
    guarded->task(guarded->arg, i);
    pbw__fp_leave(fp);
}

#ifdef PBW__THREADS
/* `work` packs three fields: the tasks not yet taken, times PBW__UNTAKEN, the tasks running, times PBW__RUNS, and
   whether the caller sleeps.  Taking a task acquires what was written before pbw__for; ending one releases what the
   task wrote to the caller.  Only running tasks read `task` and `arg`, which stay while any runs.  There are at most
   65535 tasks: >>order has the most, 16 for each of 4 shares of at most 256 threads. */
struct pbw_threads {
    pbw_memory memory;
    pbw__mutex mutex;
    pbw__condition wake, done;
    pbw__task *task;
    void *arg;
    int tasks, stop, alone;                          /* alone: each thread has a processor */
    int shared;                                      /* pbw_threads_stop stops them */
    int count;                                       /* threads started */
    unsigned work;
    pbw__thread thread[PBW__THREADS];
};
#define PBW__SLEEPS 1u
#define PBW__RUNS 2u
#define PBW__UNTAKEN 65536u

/* Takes tasks until none is left. */
static void pbw__work(pbw_threads *team)
{
    unsigned work = PBW__LOAD(&team->work);
    while (work >= PBW__UNTAKEN) {
        if (PBW__CAS_ACQUIRE(&team->work, &work, work - PBW__UNTAKEN + PBW__RUNS)) {
            PBW__TEST_PAUSE();
            team->task(team->arg, team->tasks - (int)(work / PBW__UNTAKEN));
            PBW__TEST_PAUSE();
            work = PBW__SUB_RELEASE(&team->work, PBW__RUNS) - PBW__RUNS;
            if (work == PBW__SLEEPS) {
                PBW__LOCK(&team->mutex);
                PBW__WAKE(&team->done);
                PBW__UNLOCK(&team->mutex);
            }
        }
    }
}

/* Spins for up to 0.2 ms, about the cost of a wake-up.  Returns whether tasks arrived (or all running ones ended). */
static int pbw__work_soon(const pbw_threads *team, int wanted)
{
    double start, waited = 0.0;
    unsigned work = PBW__LOAD_ACQUIRE(&team->work);
    for (start = pbw__seconds(); PBW__LOAD(&team->alone) && waited >= 0.0 && waited < 2e-4;
         waited = pbw__seconds() - start) {
        if (wanted ? work >= PBW__UNTAKEN || PBW__LOAD(&team->stop) : work < PBW__RUNS) {
            break;
        }
        work = PBW__LOAD_ACQUIRE(&team->work);
    }
    return wanted ? work >= PBW__UNTAKEN : work < PBW__RUNS;
}

static pbw__thread_result PBW__THREAD_CALL pbw__team_member(void *arg)
{
    pbw_threads *team = (pbw_threads *)arg;
    pbw__fp fp = pbw__fp_enter();
    while (!PBW__LOAD(&team->stop)) {
        pbw__work(team);
        if (!pbw__work_soon(team, 1)) {
            PBW__LOCK(&team->mutex);
            while (!PBW__LOAD(&team->stop) && PBW__LOAD(&team->work) < PBW__UNTAKEN) {
                PBW__WAIT(&team->wake, &team->mutex);
            }
            PBW__UNLOCK(&team->mutex);
        }
    }
    pbw__fp_leave(fp);
    return 0;
}

/* The stack of a thread.  Without optimisation clang's frames of vector code take 280 KiB. */
#if defined(__GNUC__) && !defined(__OPTIMIZE__)
#define PBW__STACK (1024 * 1024)
#else
#define PBW__STACK (256 * 1024)
#endif

/* Starts the threads.  Fewer are enough; with none the tasks run on the caller's thread. */
static void pbw__team_start(pbw__context *context)
{
    pbw_threads *team = (pbw_threads *)pbw__allocate(&context->memory, 1, sizeof(pbw_threads));
    if (team == NULL) {
        context->threads = 1;
        return;
    }
    memset(team, 0, sizeof(*team));
    PBW__MUTEX_INIT(&team->mutex);
    PBW__CONDITION_INIT(&team->wake);
    PBW__CONDITION_INIT(&team->done);
    while (team->count + 1 < context->threads && PBW__TEST_MAY_START()
           && pbw__thread_start(&team->thread[team->count], PBW__STACK, pbw__team_member, team)) {
        team->count++;
    }
    context->threads = team->count + 1;
    PBW__STORE(&team->alone, context->threads <= PBW__CORES());
    context->team = team;
}

static void pbw__team_stop(pbw__context *context)
{
    pbw_threads *team = context->team;
    int i;
    context->team = NULL;
    if (team == NULL || team->shared) {
        return;
    }
    PBW__LOCK(&team->mutex);
    PBW__STORE(&team->stop, 1);
    PBW__WAKE_ALL(&team->wake);
    PBW__UNLOCK(&team->mutex);
    for (i = 0; i < team->count; i++) {
        PBW__THREAD_JOIN(team->thread[i]);
    }
    PBW__CONDITION_DESTROY(&team->wake);
    PBW__CONDITION_DESTROY(&team->done);
    PBW__MUTEX_DESTROY(&team->mutex);
    pbw__release(&context->memory, team, 1, sizeof(pbw_threads));
}
#else
#define pbw__team_stop(context) ((void)(context))
#endif

/* Calls task(arg, i) for i = 0..tasks-1 on the threads of the call; returns when all calls have returned. */
static void pbw__for(pbw__context *context, int tasks, pbw__task *task, void *arg)
{
    int i;
    if (context->options.run != NULL && tasks > 1 && context->threads > 1) {
        pbw__guarded guarded = { task, arg };
        context->options.run(context->options.run_user, tasks, pbw__run_guarded, &guarded);
        return;
    }
#ifdef PBW__THREADS
    if (tasks > 1 && context->threads > 1 && context->team == NULL) {
        pbw__team_start(context);
    }
    if (tasks > 1 && context->threads > 1) {
        pbw_threads *team = context->team;
        team->task = task;
        team->arg = arg;
        team->tasks = tasks;
        PBW__STORE_RELEASE(&team->work, (unsigned)tasks * PBW__UNTAKEN);
        PBW__LOCK(&team->mutex);
        PBW__WAKE_ALL(&team->wake);
        PBW__UNLOCK(&team->mutex);
        pbw__work(team);
        while (!pbw__work_soon(team, 0)) {           /* the caller's thread is the one to report */
            PBW__LOCK(&team->mutex);
            if (PBW__ADD(&team->work, PBW__SLEEPS) >= PBW__RUNS) {
                PBW__WAIT_50MS(&team->done, &team->mutex);
            }
            (void)PBW__ADD(&team->work, 0 - PBW__SLEEPS);
            PBW__UNLOCK(&team->mutex);
            (void)pbw__report(context, 0.0);
        }
        return;
    }
#endif
    for (i = 0; i < tasks; i++) {
        task(arg, i);
    }
}

#ifdef PBW__THREADS
/* The options.run of calls that share threads; pbw__context_start takes the threads themselves. */
static void pbw__run_shared(void *user, int tasks, pbw__task *task, void *arg)
{
    pbw__context context;
    memset(&context, 0, sizeof(context));
    context.team = (pbw_threads *)user;
    context.threads = context.team->count + 1;
    pbw__for(&context, tasks, task, arg);
}
#endif

/* Returns the threads for a call on `count` points: few points are finished before a thread has started. */
static int pbw__thread_count(int asked, size_t count)
{
#ifdef PBW__THREADS
    size_t threads = (size_t)asked, most = count / PBW__SMALLER(8192) + 1;
    if (asked == 0) {
        const long cores = most > 1 ? PBW__CORES() : 1;      /* else no system call */
        threads = cores < 1 ? 1 : cores < PBW__THREADS ? (size_t)cores : PBW__THREADS;
    }
    return (int)(threads < most ? threads : most);
#else
    (void)asked;
    (void)count;
    return 1;
#endif
}

static void pbw__context_start(pbw__context *context, const pbw_options *options, size_t count)
{
    memset(context, 0, sizeof(*context));
    if (options != NULL) {
        context->options = *options;
    }
    pbw_memory_start(&context->memory, &context->options);
    context->threads = pbw__thread_count(context->options.threads, count);
#ifdef PBW__THREADS
    context->caller = PBW__THIS_THREAD();
    if (context->options.run == pbw__run_shared) {
        context->team = (pbw_threads *)context->options.run_user;
        context->options.run = NULL;
    }
#endif
}

PBWDEF pbw_threads *pbw_threads_start(const pbw_options *options, size_t count, pbw_options *inner)
{
    pbw__context context;
    pbw__context_start(&context, options, count);
    *inner = options == NULL ? context.options : *options;
#ifdef PBW__THREADS
    if (context.threads > 1 && inner->threads >= 0 && inner->threads <= 256 && inner->run == NULL) {
        pbw__team_start(&context);
    }
    if (context.team != NULL && inner->run == NULL) {
        context.team->memory = context.memory;
        context.team->shared = 1;
        inner->threads = context.threads;
        inner->memory_limit = pbw_memory_left(&context.memory);
        inner->run = pbw__run_shared;
        inner->run_user = context.team;
        return context.team;
    }
#endif
    return NULL;
}

PBWDEF void pbw_threads_stop(pbw_threads *threads)
{
#ifdef PBW__THREADS
    pbw__context context;
    if (threads != NULL) {
        memset(&context, 0, sizeof(context));
        context.memory = threads->memory;
        context.team = threads;
        threads->shared = 0;
        pbw__team_stop(&context);
    }
#else
    (void)threads;
#endif
}

/* Begins a call of the interface on `count` points.  Returns PBW_OK, or the reason to end it before it enters a
   stage; pbw__end_call must follow in either case. */
static pbw_status pbw__begin_call(pbw__context *context, const pbw_options *options, size_t count)
{
    pbw__context_start(context, options, count);
    context->fp = pbw__fp_enter();
    return context->options.threads < 0 || context->options.threads > 256 ? PBW_ERROR_ARGUMENT
         : pbw__fp_is_exact() ? PBW_OK : PBW_ERROR_FP_MODE;
}

static pbw_status pbw__end_call(pbw__context *context, pbw_status status)
{
    status = status == PBW_OK && pbw__report(context, 1.0) ? PBW_CANCELLED : status;
    pbw__team_stop(context);
    pbw__fp_leave(context->fp);
    return status;
}

/* Returns into how many tasks to cut `count` items, of at least `least` each. */
static int pbw__tasks(const pbw__context *context, size_t count, size_t least)
{
    size_t most = context->threads > 1 ? (size_t)context->threads * 4 : 1, tasks = count / PBW__SMALLER(least);
    return (int)(tasks < 1 ? 1 : tasks < most ? tasks : most);
}

/* Returns where the i-th of `tasks` shares of `count` items begins. */
PBW__INLINE size_t pbw__share(size_t count, int i, int tasks)
{
    return count / (size_t)tasks * (size_t)i + count % (size_t)tasks * (size_t)i / (size_t)tasks;
}

/* ---- bytes by many threads; completes even if the call is cancelled */
typedef struct pbw__setting {
    unsigned char *start;
    const unsigned char *source;                     /* NULL: all become `value` */
    size_t bytes;
    int value, tasks;
} pbw__setting;

static void pbw__set_share(void *arg, int task)
{
    const pbw__setting *setting = (const pbw__setting *)arg;
    const size_t from = pbw__share(setting->bytes, task, setting->tasks);
    const size_t bytes = pbw__share(setting->bytes, task + 1, setting->tasks) - from;
    if (setting->source != NULL) {
        memcpy(setting->start + from, setting->source + from, bytes);
    } else {
        memset(setting->start + from, setting->value, bytes);
    }
}

static void pbw__set_or_copy(pbw__context *context, void *start, const void *source, int value, size_t bytes)
{
    pbw__setting setting = { (unsigned char *)start, (const unsigned char *)source, bytes, value, 1 };
    setting.tasks = pbw__tasks(context, bytes, 65536);
    pbw__for(context, setting.tasks, pbw__set_share, &setting);
}

static void pbw__set_bytes(pbw__context *context, void *start, int value, size_t bytes)
{
    pbw__set_or_copy(context, start, NULL, value, bytes);
}

/* body(arg, from, to) for each range of `grain` items.  Threads take ranges in ascending order, so all ranges below
   one that fails have begun before it, and the lowest failure does not depend on the threads. */
typedef struct pbw__ranges {
    pbw__context *context;
    pbw_body *body;
    void *arg;
    size_t count, grain, blocks, next;               /* next: the first range that no thread has taken */
    size_t failure;                                  /* 64 * the lowest range that failed + its status; or -1 */
    double begin, end;                               /* of the stage's progress */
} pbw__ranges;

static void pbw__take_ranges(void *arg, int task)
{
    pbw__ranges *ranges = (pbw__ranges *)arg;
    const double step = (ranges->end - ranges->begin) / (double)ranges->blocks;
    size_t block, failure, old = PBW__LOAD(&ranges->failure);
    (void)task;
    while (old == (size_t)-1 && (block = PBW__ADD(&ranges->next, 1)) < ranges->blocks) {
        const size_t from = block * ranges->grain, rest = ranges->count - from;
        if (pbw__report(ranges->context, ranges->begin + step * (double)block)) {
            return;
        }
        failure = block * 64 + (size_t)ranges->body(ranges->arg, from, rest < ranges->grain ? ranges->count
                                                                                              : from + ranges->grain);
        old = PBW__LOAD(&ranges->failure);
        while (failure % 64 != PBW_OK && failure < old && !PBW__CAS(&ranges->failure, &old, failure)) {
        }
        old = failure % 64 != PBW_OK ? failure : old;
    }
}

/* Progress goes on to `end`.  Returns PBW_OK, PBW_CANCELLED or the lowest failure. */
static pbw_status pbw__for_range(pbw__context *context, size_t count, size_t grain, double end, pbw_body *body,
                                 void *arg)
{
    const size_t blocks = count / grain + (count % grain != 0);
    pbw__ranges ranges = { context, body, arg, count, grain, blocks, 0, (size_t)-1, 0.0, 0.0 };
    ranges.begin = context->reached;
    ranges.end = context->reached = pbw__max(end, context->reached);
    pbw__for(context, context->threads <= 1 ? 1 : blocks < (size_t)context->threads ? (int)blocks : context->threads,
             pbw__take_ranges, &ranges);
    return ranges.failure != (size_t)-1 ? (pbw_status)(ranges.failure % 64)
         : PBW__LOAD(&context->cancelled) ? PBW_CANCELLED : PBW_OK;
}
/* ------------------------------------------------------------------------------------------------------
   >>exact        Integers of just enough width, and the one determinant that is computed with them.
   In: finite doubles, read as mantissa * 2^exponent.  Out: the exact sign of an orientation or power determinant.
   Integer arithmetic only: right in every rounding mode, with and without flush-to-zero.  Common scale instead of
   expansions, because no exponent is too extreme for it and there is nothing to prove about roundings.

   A number is a row of digits in radix R = 2^58: value = sum digit[i] R^i with 0 <= digit[i] < R below the top one,
   which is signed.  A product of two digits takes 116 bits of a 128-bit column, so whole columns are summed before
   one carry is taken, signs need no cases, and the shortest numbers (a difference of ordinary coordinates is one
   digit) cost a few multiplications.  Without __int128 the radix is 2^26 and the column has 64 bits.
   Right shifts of negative columns must be arithmetic: all compilers that we know of do it, tests/ would see others.

   Widths.  A finite double is a multiple of 2^-1074 below 2^1024.  In that unit differences are < 2^2099, 2x2 minors
   < 2^4199, 3x3 minors < 2^6302, lifts |u|^2 - dw (unit 2^-2148) < 2^4201, so
      digits held    12 differences of 37, 6 minors of 73, 4 minors of 109, 4 lifts of 73, 4 weights of 55, and
                     the last sum of 183 digits: 2013 digits, 117,000 bits, 17 KiB;
      column         at most 4 terms of 73 products below 2^116, and a carry: below 2^125
                     (radix 2^26: 4 terms of 162 products below 2^52: below 2^62).
   Low digits that are zero are skipped: where one axis is far finer than the others, most are.
   ------------------------------------------------------------------------------------------------------ */
#if defined(__SIZEOF_INT128__)
typedef int64_t pbw__digit;
__extension__ typedef __int128 pbw__column;
__extension__ typedef unsigned __int128 pbw__wrapped;
#define PBW__DIGIT_BITS 58
#else
typedef int32_t pbw__digit;
typedef int64_t pbw__column;
typedef uint64_t pbw__wrapped;
#define PBW__DIGIT_BITS 26
#endif
#define PBW__POOL (125000 / PBW__DIGIT_BITS)

typedef struct pbw__integer {
    pbw__digit *digit;
    int low, length;                                 /* digit[low] and digit[length-1] are not 0; 0, 0: zero */
} pbw__integer;

typedef struct pbw__product {                        /* factor[0] * factor[1], to be added or subtracted */
    const pbw__integer *factor[2];
    int negative;
} pbw__product;

PBW__INLINE uint64_t pbw__bits(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

PBW__INLINE double pbw__power_of_two(int exponent)
{
    const uint64_t bits = (uint64_t)(exponent < -1022 ? 1 : exponent > 1023 ? 2046 : exponent + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof(power));
    return power;
}

/* value = mantissa * 2^exponent; the exponent is returned, |mantissa| < 2^53. */
PBW__INLINE int pbw__decode(double value, int64_t *mantissa)
{
    const uint64_t bits = pbw__bits(value);
    const int64_t minus = -(int64_t)(bits >> 63);    /* -1 or 0: no branch on a random sign */
    const int field = (int)(bits >> 52 & 2047);
    *mantissa = (int64_t)((bits & 0xfffffffffffff) | (uint64_t)(field != 0) << 52);
    *mantissa = (*mantissa ^ minus) - minus;
    return (field != 0 ? field : 1) - 1075;
}

/* Returns the lowest exponent of `count` numbers that are not 0, or `unit` if that is lower. */
PBW__DEVICE static int pbw__exact_unit(const double *number, int count, int unit)
{
    int64_t mantissa;
    int i;
    for (i = 0; i < count; i++) {
        const int exponent = pbw__decode(number[i], &mantissa);
        unit = mantissa != 0 && exponent < unit ? exponent : unit;
    }
    return unit;
}

/* Takes the number in the first `length` digits of the pool, without leading zeros or, if it is negative, leading
   -1. */
PBW__DEVICE static pbw__integer pbw__trimmed(pbw__digit **pool, int length)
{
    pbw__digit *digit = *pool;
    pbw__integer result;
    while (length > 1 && digit[length - 1] == -1) {
        digit[length - 2] -= (pbw__digit)1 << PBW__DIGIT_BITS;
        length--;
    }
    while (length > 0 && digit[length - 1] == 0) {
        length--;
    }
    result.digit = digit;
    result.length = length;
    for (result.low = 0; result.low < length && digit[result.low] == 0; result.low++) {
    }
    *pool += length;
    return result;
}

/* Returns a - b in units of 2^unit; the lowest bit of both is worth at least one unit. */
PBW__DEVICE static pbw__integer pbw__exact_difference(double a, double b, int unit, pbw__digit **pool)
{
    pbw__digit *digit = *pool;
    pbw__column carry = 0;
    int i, length = 0, side;
    for (side = 0; side < 2; side++) {
        int64_t mantissa;
        int shift = pbw__decode(side == 0 ? a : b, &mantissa) - unit;
        int negative = (mantissa < 0) != side, at, room;
        uint64_t rest = (uint64_t)(mantissa < 0 ? -mantissa : mantissa);
        at = shift / PBW__DIGIT_BITS;
        room = PBW__DIGIT_BITS - shift % PBW__DIGIT_BITS;
        while (rest != 0) {                          /* the piece of the mantissa that falls into digit at */
            pbw__digit piece = (pbw__digit)((rest & (((uint64_t)1 << room) - 1)) << (PBW__DIGIT_BITS - room));
            while (length <= at) {
                digit[length++] = 0;
            }
            digit[at] += negative ? -piece : piece;
            rest >>= room;
            room = PBW__DIGIT_BITS;
            at++;
        }
    }
    for (i = 0; i < length; i++) {
        carry += digit[i];
        digit[i] = (pbw__digit)(carry & (((pbw__column)1 << PBW__DIGIT_BITS) - 1));
        carry >>= PBW__DIGIT_BITS;
    }
    digit[length++] = (pbw__digit)carry;
    return pbw__trimmed(pool, length);
}

/* Returns the sum of `count` products, column by column. */
PBW__DEVICE static pbw__integer pbw__exact_sum(const pbw__product *product, int count, pbw__digit **pool)
{
    pbw__digit *digit = *pool;
    pbw__column column = 0;
    int i, j, k, length = 0, low = 2 * PBW__POOL;
    for (j = 0; j < count; j++) {
        const pbw__integer *a = product[j].factor[0], *b = product[j].factor[1];
        if (a->length > 0 && b->length > 0) {
            length = a->length + b->length > length ? a->length + b->length : length;
            low = a->low + b->low < low ? a->low + b->low : low;
        }
    }
    for (k = 0; k < low && k < length; k++) {
        digit[k] = 0;
    }
    for (; k < length; k++) {
        for (j = 0; j < count; j++) {
            const pbw__integer *a = product[j].factor[0], *b = product[j].factor[1];
            const int last = k - b->low < a->length ? k - b->low : a->length - 1;
            pbw__column sum = 0;
            for (i = k - b->length < a->low ? a->low : k - b->length + 1; i <= last; i++) {
                sum += (pbw__column)a->digit[i] * b->digit[k - i];
            }
            column += product[j].negative ? -sum : sum;
        }
        digit[k] = (pbw__digit)(column & (((pbw__column)1 << PBW__DIGIT_BITS) - 1));
        column >>= PBW__DIGIT_BITS;
    }
    digit[length++] = (pbw__digit)column;
    return pbw__trimmed(pool, length);
}

PBW__DEVICE static int pbw__exact_sign(const pbw__integer *a)
{
    return a->length == 0 ? 0 : a->digit[a->length - 1] < 0 ? -1 : 1;
}

/* Returns the sign of a predicate, see >>predicates: an orientation if count is dim, a power determinant if it is
   dim+1.  The latter stores orientation[i] too: that of the simplex row[0..dim] with corner i replaced by the origin.
   pool: room for PBW__POOL digits.  Minors are built up by columns x, y, z, lift: minor[set] is the determinant of
   the rows row[i] - origin in the set and of the same number of first columns, expanded by its last column. */
PBW__DEVICE static int pbw__exact_determinant_in(pbw__digit *pool, int dim, int count, const double *const *row,
                                                 const double *origin, int *orientation)
{
    pbw__digit *top = pool, one_digit = 1;
    pbw__integer entry[4][4], minor[16], one = { &one_digit, 0, 1 };
    pbw__product term[4];
    int unit = 2048, sign = 0, missing = 0, i, j, k, set;
    for (i = 0; i <= count && count > dim; i++) {    /* a unit whose square divides all weights */
        unit = pbw__exact_unit((i < count ? row[i] : origin) + dim, 1, unit);
    }
    unit = (unit - (unit & 1)) / 2;
    for (i = 0; i <= count; i++) {                   /* and that divides all coordinates */
        unit = pbw__exact_unit(i < count ? row[i] : origin, dim, unit);
    }
    for (i = 0; i < count; i++) {
        for (j = 0; j < dim; j++) {
            entry[i][j] = pbw__exact_difference(row[i][j], origin[j], unit, &top);
            term[j].factor[0] = term[j].factor[1] = &entry[i][j];
            term[j].negative = 0;
        }
        if (count > dim) {
            pbw__integer weight = pbw__exact_difference(row[i][dim], origin[dim], 2 * unit, &top);
            term[dim].factor[0] = &weight;
            term[dim].factor[1] = &one;
            term[dim].negative = 1;
            entry[i][dim] = pbw__exact_sum(term, dim + 1, &top);
        }
    }
    minor[0] = one;
    for (set = 1; set < 1 << count; set++) {
        for (i = k = 0; i < count; i++) {
            k += set >> i & 1;
            missing = set >> i & 1 ? missing : i;
        }
        for (i = j = 0; i < count; i++) {
            if (set >> i & 1) {
                term[j].factor[0] = &entry[i][k - 1];
                term[j].factor[1] = &minor[set ^ (1 << i)];
                term[j].negative = (k - 1 - j) & 1;
                j++;
            }
        }
        minor[set] = k == 1 ? *term[0].factor[0] : pbw__exact_sum(term, k, &top);
        sign = pbw__exact_sign(&minor[set]);
        if (k == dim && count > dim) {
            orientation[missing] = missing % 2 == 0 ? sign : -sign;
        }
    }
    return dim == 2 ? sign : -sign;                  /* of the set of all rows */
}

/* ------------------------------------------------------------------------------------------------------
   >>grid         The coarsest grid that holds all records.
   In: records of coordinates and, if there are weights, a weight.  Out: their grid, or that there is none.
   Holds: every coordinate is a multiple of the unit and every weight of its square, exactly.
   ------------------------------------------------------------------------------------------------------ */
/* The common grid of a build's records.  inverse_unit is 0 if they have no common grid, else a power of two:
   coordinates are multiples of the unit and weights of its square, and they differ by less than 2^bits units and
   4^bits unit^2.  grid NULL: the caller is a public predicate, so ranges and the rounding mode are checked first. */
typedef struct pbw__grid {
    double inverse_unit;
    int bits;
} pbw__grid;

/* The grid of a share of the records: its unit 2^unit, the extremes, and limit: 2^52 units, of coordinates and of
   weights.  PBW__NO_UNIT: the grid would be too fine, as it is at once for random doubles. */
typedef struct pbw__grid_share { int unit; double low[4], high[4], limit[2]; } pbw__grid_share;
#define PBW__NO_UNIT (-501)

PBW__DEVICE static void pbw__grid_share_reset(pbw__grid_share *share)
{
    int k;
    share->unit = 501;
    for (k = 0; k < 4; k++) {
        share->low[k] = DBL_MAX;
        share->high[k] = -DBL_MAX;
    }
    share->limit[0] = share->limit[1] = HUGE_VAL;
}

/* Stores 1 / unit and the longest side in units; returns 0 if that is too long for a grid. */
static int pbw__grid_span(const pbw__grid_share *share, int dim, double *inverse, double *span)
{
    uint64_t pattern = (uint64_t)(1023 - share->unit) << 52;
    int k;
    if (share->unit < -500 || share->unit > 500) {
        return 0;
    }
    memcpy(inverse, &pattern, sizeof(pattern));
    for (*span = 0.0, k = 0; k < dim; k++) {
        *span = pbw__max(*span, (share->high[k] - share->low[k]) * *inverse);
    }
    return *span < 9007199254740992.0;
}

/* Refines the unit of a share so that it fits this record too, of `width` entries. */
static PBW__NOINLINE void pbw__grid_refine(pbw__grid_share *share, const double *q, int dim, int width)
{
    int old = share->unit, k;
    double inverse, span;
    for (k = 0; k < width; k++) {
        int64_t mantissa;
        int exponent = pbw__decode(q[k], &mantissa), finest = k < dim ? share->unit : 2 * share->unit;
        if (mantissa != 0 && exponent < finest
            && (finest - exponent > 52 || (mantissa & (((int64_t)1 << (finest - exponent)) - 1)) != 0)) {
            while (mantissa % 2 == 0) {              /* off the grid: the lowest bit makes a finer one */
                mantissa /= 2;
                exponent++;
            }
            share->unit = k < dim ? exponent : (exponent - (exponent & 1)) / 2;
        }
    }
    if (share->unit == old) {
        return;
    }
    if (pbw__grid_span(share, dim, &inverse, &span)) {
        share->limit[0] = 4503599627370496.0 / inverse;
        share->limit[1] = share->limit[0] / inverse;
    } else {
        share->unit = PBW__NO_UNIT;
    }
}

/* A number is on the grid if it is of 2^52 units or more, or the sum of its size and 2^52 units is not rounded.  Adds
   the records from *from on to a share, up to `end` or to the first that is off the grid, and moves *from behind it.
   Returns whether there was one. */
static int pbw__grid_scan_scalar(pbw__grid_share *share, const double **from, const double *end, int dim, int width)
{
    const double *q = *from;
    uint64_t off = 0;
    int k;
    for (; q < end && off == 0; q += width) {
        for (k = 0; k < width; k++) {
            const double x = q[k], many = share->limit[k == dim], size = pbw__abs(x) < many ? pbw__abs(x) : many;
            off |= pbw__bits(size + many - many - size);
            share->low[k] = x < share->low[k] ? x : share->low[k];
            share->high[k] = x > share->high[k] ? x : share->high[k];
        }
    }
    *from = q;
    return off != 0;
}

#ifdef PBW__SIMD
/* The same by vectors, as far as they fit: lanes from `width` on have numbers of the next record and the limit 0,
   which holds for all numbers. */
PBW__SIMD static int pbw__grid_scan_simd(pbw__grid_share *share, const double **from, const double *end, int dim,
                                         int width)
{
    const double *q = *from, *last = end - 4, *limit = share->limit;
    const pbw__d4 many = pbw__four(limit[0], limit[0], width > 2 ? limit[dim == 2] : 0.0, width > 3 ? limit[1] : 0.0);
    pbw__d4 low = pbw__load4d(share->low), high = pbw__load4d(share->high);
    unsigned on = 15;
    for (; q <= last && on == 15; q += width) {
        const pbw__d4 x = pbw__load4d(q), size = pbw__min4(pbw__abs4(x), many);
        low = pbw__min4(x, low);
        high = pbw__max4(x, high);
        on = pbw__signs(pbw__equal(size + many - many, size));
    }
    memcpy(share->low, &low, (size_t)width * sizeof(double));
    memcpy(share->high, &high, (size_t)width * sizeof(double));
    *from = q;
    return on != 15;
}
#endif

/* Adds `count` records of `width` entries, from q on, to a share. */
static void pbw__grid_add(pbw__grid_share *share, const double *q, size_t count, int dim, int width)
{
    const double *end = q + count * (size_t)width;
    while (q < end && share->unit != PBW__NO_UNIT) {
        int off = 0;
#ifdef PBW__SIMD
        if (end - q >= 4 && pbw__simd_works()) {
            off = pbw__grid_scan_simd(share, &q, end, dim, width);
        } else
#endif
        {
            off = pbw__grid_scan_scalar(share, &q, end, dim, width);
        }
        if (off) {
            pbw__grid_refine(share, q - width, dim, width);
        }
    }
}

/* Stores the coarsest grid that holds the records of all shares, of dim coordinates and a weight, if differences are
   below 2^53 units, so that doubles hold them. */
static void pbw__grid_close(pbw__grid *grid, const pbw__grid_share *shares, int count, int dim)
{
    pbw__grid_share all;
    double inverse = 0.0, span = 0.0, limit = 1.0;
    int bits = 0, i, k;
    memset(grid, 0, sizeof(*grid));
    pbw__grid_share_reset(&all);
    for (i = 0; i < count; i++) {
        all.unit = shares[i].unit < all.unit ? shares[i].unit : all.unit;
        for (k = 0; k <= dim; k++) {
            all.low[k] = shares[i].low[k] < all.low[k] ? shares[i].low[k] : all.low[k];
            all.high[k] = shares[i].high[k] > all.high[k] ? shares[i].high[k] : all.high[k];
        }
    }
    if (!pbw__grid_span(&all, dim, &inverse, &span)) {
        return;
    }
    while (bits < 54 && !(span < limit && (all.high[dim] - all.low[dim]) * inverse * inverse < limit * limit)) {
        limit *= 2.0;
        bits++;
    }
    if (bits < 54) {
        grid->inverse_unit = inverse;
        grid->bits = bits;
    }
}


/* ------------------------------------------------------------------------------------------------------
   >>predicates   Signs: filter, integers, pairs of doubles, exact determinant; and the verdict on ties.
   In: records of the kernel, {x, y, w} in the plane and {x, y, z, w} in space; w = 0 without weights; all finite.
   Out: exact signs, and for each positive simplex and point the one perturbed answer: in conflict or not.

   Every predicate is a determinant of rows row[i] - origin; the origin is the last point of the call:
      orient   dim rows:    the orientation of the simplex (row[0] .. row[dim-1], origin)
      power    dim+1 rows:  sum_i lift_i * orientation_i, where lift_i = |row[i] - origin|^2 - (w[i] - w[origin]) and
                            orientation_i is that of the simplex row[0..dim] with corner i replaced by the origin:
                            +1 for an origin in conflict with a positive simplex
   Stages, from the cheapest (power3: 20, 50 to 110, 160, 1400 ns); each but the last may leave the sign open.
   Integers come before pairs because they also decide zeros and give the orientations that break ties.

      filter      plain doubles and a bound; any rounding mode, with and without flush-to-zero
      integers    for differences that fit one digit of >>exact in a common unit: nearly all that a filter leaves
                  open, so true zeros mostly end here; nothing is rounded, so again any mode
      pairs       unevaluated sums of two doubles, 93 correct bits; only where rounding is known to be to nearest
      >>exact     all finite doubles
   ------------------------------------------------------------------------------------------------------ */
/* ---- the bounds
   All error bounds of this file; tests/gappa.py proves each one for the operations that it belongs to.
   A determinant is a sum of products of differences.  A rounding multiplies a product by 1 + d, |d| <= u: so with n
   roundings on each product, the error is at most n u / (1 - n u) times the sum of the absolute products (Higham
   2002, section 3.1).  u is 2^-53 in round-to-nearest and 2^-52 in any mode.  A fused operation saves a rounding.
   mx, my, mz are the largest |x|, |y|, |z| and ml the largest |row - origin|^2 + |dw| of this very test: no bound
   depends on the rest of the input.  In the kernels h is ml, so |x|, |y|, |z| <= h^(1/2).

                roundings on a product                                absolute products       bound
      orient2   2 differences, product, sum                      4    2 mx my                   8 u mx my
      orient3   4, difference, product, 2 sums                   8    6 mx my mz               48 u mx my mz
      power2    lift 2+1+1+1, minor 4, product, 2 sums          12    6 mx my ml               72 u mx my ml
      power3    lift 2+1+2+1, minor 8, product, 2 sums          17    24 mx my mz ml          408 u mx my mz ml
      circle    the kernels' power2, one rounding more          13    6 h^2                    78 u h^2
      sphere    the kernels' power3, two roundings more         19    24 h^(5/2)              456 u h^(5/2)
      ear       orient3, two sums more                          10    24 h^(3/2)              240 u h^(3/2)
      thin      circle, by the sum of the absolute products     13    that sum                 13 u that sum
      pairs     see there
      reach     difference twice, product, 2 sums, weight        6    |v - q|^2 + |w|            6 u that sum

   The squared distance of pbw_query.h is compared in any rounding mode, with one rounding more in the difference.
   The constants leave about one percent, for the roundings of the bound itself and what underflow takes. */
#define PBW__FILTER_ORIENT2_ERROR 8.1                /* times 2^-52: any rounding mode */
#define PBW__FILTER_ORIENT3_ERROR 48.5
#define PBW__FILTER_POWER2_ERROR 72.8
#define PBW__FILTER_POWER3_ERROR 412.0
#define PBW__PAIRS_ORIENT2_ERROR 31.0                /* times u^2 */
#define PBW__PAIRS_ORIENT3_ERROR 382.0
#define PBW__PAIRS_POWER2_ERROR 794.0
#define PBW__PAIRS_POWER3_ERROR 6133.0
#define PBW__ORIENT2_ERROR 9e-16                     /* the kernels': times h, h^(3/2), h^2, h^(5/2) */
#define PBW__ORIENT3_ERROR 5.4e-15
#define PBW__CIRCLE_ERROR 9e-15
#define PBW__SPHERE_ERROR 5.2e-14
#define PBW__EAR_ERROR 2.8e-14                       /* of Q in pbw_live.h: times h^(3/2) */
#define PBW__TIME_ERROR 1.25                         /* of P / Q: times the error of P, and P / Q times that of Q */
#define PBW__TIME_LEAST 64.0                         /* times the error of Q: where P / Q is used */
#define PBW__THIN_ERROR 1.5e-15                      /* times the sum of the absolute products */
#define PBW__CIRCLE_PAIRS_ERROR 9e-30                /* the kernels' in pairs: times h^2, h^(5/2) */
#define PBW__SPHERE_PAIRS_ERROR 9e-29
#define PBW__REACH_ERROR 8.0                         /* times 2^-52 and |v - q|^2 + |w|: any rounding mode */
/* Heights below which the kernels' determinants are exact, in units of a grid, squared: there all partial results are
   integers below 2^53, as 6 H^2 and 24 H^(5/2) are. */
#define PBW__EXACT_HEIGHT2 3.8e7
#define PBW__EXACT_HEIGHT3 6.5e5

#define PBW__OPEN 2                                  /* a stage's answer if it does not know the sign */

/* Returns the sign of a value whose error is below bound.  low: the least of mx, my, mz; high: the largest, or ml.
   In this range nothing overflows: 6 high^3 and 24 high^2.5 are below 1e301.  An underflow, or a denormal read as 0,
   costs less than 2^-1020, and the products of maxima are above 1e-250: a relative 2^-189.  NaN leaves it open. */
PBW__INLINE int pbw__certain(double value, double bound, double low, double high)
{
    if (low > 1e-50 && high < 1e100) {
        if (value > bound) {
            return 1;
        }
        if (value < -bound) {
            return -1;
        }
    }
    return PBW__OPEN;
}

/* ---- filter */
PBW__INLINE int pbw__filter_orient2(const double *a, const double *b, const double *c)
{
    double x0 = a[0] - c[0], y0 = a[1] - c[1];
    double x1 = b[0] - c[0], y1 = b[1] - c[1];
    double mx = pbw__max_abs(x0, x1, x1, x1), my = pbw__max_abs(y0, y1, y1, y1);
    double det = x0 * y1 - x1 * y0;
    return pbw__certain(det, PBW__FILTER_ORIENT2_ERROR * DBL_EPSILON * mx * my, mx < my ? mx : my, pbw__max(mx, my));
}

PBW__INLINE int pbw__filter_orient3(const double *a, const double *b, const double *c, const double *d)
{
    double x0 = a[0] - d[0], y0 = a[1] - d[1], z0 = a[2] - d[2];
    double x1 = b[0] - d[0], y1 = b[1] - d[1], z1 = b[2] - d[2];
    double x2 = c[0] - d[0], y2 = c[1] - d[1], z2 = c[2] - d[2];
    double mx = pbw__max_abs(x0, x1, x2, x2), my = pbw__max_abs(y0, y1, y2, y2), mz = pbw__max_abs(z0, z1, z2, z2);
    double low = mx < my ? mx : my, high = pbw__max(mx, my);
    double det = z1 * (x0 * y2 - x2 * y0) - z0 * (x1 * y2 - x2 * y1) - z2 * (x0 * y1 - x1 * y0);
    return pbw__certain(det, PBW__FILTER_ORIENT3_ERROR * DBL_EPSILON * mx * my * mz, low < mz ? low : mz,
                        pbw__max(high, mz));
}

PBW__INLINE int pbw__filter_power2(const double *a, const double *b, const double *c, const double *p)
{
    double x0 = a[0] - p[0], y0 = a[1] - p[1], w0 = a[2] - p[2], l0 = x0 * x0 + y0 * y0;
    double x1 = b[0] - p[0], y1 = b[1] - p[1], w1 = b[2] - p[2], l1 = x1 * x1 + y1 * y1;
    double x2 = c[0] - p[0], y2 = c[1] - p[1], w2 = c[2] - p[2], l2 = x2 * x2 + y2 * y2;
    double mx = pbw__max_abs(x0, x1, x2, x2), my = pbw__max_abs(y0, y1, y2, y2);
    double ml = pbw__max(pbw__max(l0 + pbw__abs(w0), l1 + pbw__abs(w1)), l2 + pbw__abs(w2));
    double det = (l0 - w0) * (x1 * y2 - x2 * y1) - (l1 - w1) * (x0 * y2 - x2 * y0) + (l2 - w2) * (x0 * y1 - x1 * y0);
    return pbw__certain(det, PBW__FILTER_POWER2_ERROR * DBL_EPSILON * mx * my * ml, mx < my ? mx : my, ml);
}

PBW__INLINE int pbw__filter_power3(const double *a, const double *b, const double *c, const double *d,
                                   const double *p)
{
    double x0 = a[0] - p[0], y0 = a[1] - p[1], z0 = a[2] - p[2], w0 = a[3] - p[3], l0 = x0 * x0 + y0 * y0 + z0 * z0;
    double x1 = b[0] - p[0], y1 = b[1] - p[1], z1 = b[2] - p[2], w1 = b[3] - p[3], l1 = x1 * x1 + y1 * y1 + z1 * z1;
    double x2 = c[0] - p[0], y2 = c[1] - p[1], z2 = c[2] - p[2], w2 = c[3] - p[3], l2 = x2 * x2 + y2 * y2 + z2 * z2;
    double x3 = d[0] - p[0], y3 = d[1] - p[1], z3 = d[2] - p[2], w3 = d[3] - p[3], l3 = x3 * x3 + y3 * y3 + z3 * z3;
    double mx = pbw__max_abs(x0, x1, x2, x3), my = pbw__max_abs(y0, y1, y2, y3), mz = pbw__max_abs(z0, z1, z2, z3);
    double ml = pbw__max_abs(l0 + pbw__abs(w0), l1 + pbw__abs(w1), l2 + pbw__abs(w2), l3 + pbw__abs(w3));
    double s01 = x0 * y1 - x1 * y0, s02 = x0 * y2 - x2 * y0, s03 = x0 * y3 - x3 * y0;
    double s12 = x1 * y2 - x2 * y1, s13 = x1 * y3 - x3 * y1, s23 = x2 * y3 - x3 * y2;
    double det = ((l0 - w0) * (z1 * s23 - z2 * s13 + z3 * s12) - (l1 - w1) * (z0 * s23 - z2 * s03 + z3 * s02))
               + ((l2 - w2) * (z0 * s13 - z1 * s03 + z3 * s01) - (l3 - w3) * (z0 * s12 - z1 * s02 + z2 * s01));
    double low = mx < my ? mx : my;
    return pbw__certain(det, PBW__FILTER_POWER3_ERROR * DBL_EPSILON * mx * my * mz * ml, low < mz ? low : mz, ml);
}

/* ---- integers
   R is the radix of >>exact, 2^58 (2^26 without __int128).  With |x|, |y|, |z| <= R and |dw| <= R^2:
   |cross| <= 2 R^2, |minor| <= 3 sqrt(3) R^3 (Hadamard), |lift| <= 4 R^2.  So top digits are at most 2 R, 5.2 R and
   4 R, and a column of the last sum, of 4 rows with at most two products each, stays below 2^123 (2^59).
   Rows are small if |x| < 2^24 (2^11) and |dw| < 2^48 (2^22), as near points of a lattice are.  Then cross is below
   2^49 (2^23) and lift below 2^50 (2^24): single digits.
   Faint axes, finer than 1e-62 of the others, have a unit V of their own: it changes no orientation.  A power
   determinant is A U^2 + B V^2, integers as above, by lifts along the other axes, less weights, and along faint ones.
   |B| < 63 R^5, and U / V > 2^149, as doubles differ by 0 or 2^-53 of themselves.  So A decides, or if it is 0, B. */
#define PBW__SMALL (PBW__DIGIT_BITS == 58 ? 24 : 11)

typedef struct pbw__rows {
    pbw__digit x[4], y[4], z[4];                     /* in the plane z is 0 */
    pbw__column w[4], spread;                        /* spread < 2^PBW__SMALL: small */
    int faint;                                       /* bit k: axis k */
} pbw__rows;

/* floor(mantissa * 2^shift) modulo 2^64; bits below 1 are remembered in lost. */
PBW__INLINE uint64_t pbw__shifted(int64_t mantissa, int shift, uint64_t *lost)
{
    if (shift >= 0) {
        return shift < 64 ? (uint64_t)mantissa << shift : 0;
    }
    shift = shift > -63 ? -shift : 63;
    *lost |= (uint64_t)mantissa << (64 - shift);
    return (uint64_t)(mantissa >> shift);
}

/* Returns the least e with |x| < 2^e; for a denormal -1022. */
PBW__INLINE int pbw__exponent(double x)
{
    return (int)(pbw__bits(x) >> 52 & 2047) - 1022;
}

/* Stores the rows in the unit of the grid, else in the finest unit in which they fit, faint axes as their coordinates
   do, for differences may be flushed.  Returns 0 if a bit is finer.  Without a grid, coordinates are read modulo 2^64
   and weights modulo 2^128 (2^64): their differences are smaller. */
PBW__INLINE int pbw__read_rows(int dim, int count, const double *const *row, const double *origin,
                               const pbw__grid *grid, pbw__rows *rows)
{
    pbw__digit *axis[3] = { rows->x, rows->y, rows->z };
    uint64_t start[3] = { 0, 0, 0 }, lost = 0;
    int64_t mantissa;
    int i, k, unit, fine = -2000;
    memset(rows, 0, sizeof(*rows));
    if (grid != NULL && grid->inverse_unit != 0.0 && grid->bits <= PBW__DIGIT_BITS) {
        unit = 1 - pbw__exponent(grid->inverse_unit);
        for (i = 0; i < count; i++) {
            for (k = 0; k < dim; k++) {              /* exact: a multiple of the unit, less than 2^53 of them */
                axis[k][i] = (pbw__digit)((row[i][k] - origin[k]) * grid->inverse_unit);
                rows->spread |= axis[k][i] < 0 ? -axis[k][i] : axis[k][i];
            }
        }
    } else {
        double span[4] = { 0.0, 0.0, 0.0, 0.0 }, largest = 0.0;
        for (k = 0; k < dim + (count > dim); k++) {
            for (i = 0; i < count; i++) {
                span[k] = pbw__max(span[k], pbw__abs(row[i][k] - origin[k]));
            }
            largest = k < dim ? pbw__max(largest, span[k]) : largest;
        }
        largest = largest > 1e-150 ? largest : DBL_MAX;      /* that may be flushed: all are faint, no weights fit */
        for (k = 0; k < dim; k++) {
            if (!(span[k] > 1e-62 * largest)) {
                rows->faint |= 1 << k;
                for (i = 0; i <= count; i++) {
                    const int exponent = pbw__exponent(i < count ? row[i][k] : origin[k]) + 1 - PBW__DIGIT_BITS;
                    fine = exponent > fine ? exponent : fine;
                }
            }
        }
        unit = pbw__exponent(largest);
        k = (pbw__exponent(span[dim]) + 2049) / 2 - 1024;    /* half of it, rounded up */
        unit = (k > unit ? k : unit) - PBW__DIGIT_BITS;
        for (i = count; i >= 0 && lost == 0; i--) {
            for (k = 0; k < dim; k++) {
                int exponent = pbw__decode(i < count ? row[i][k] : origin[k], &mantissa);
                uint64_t value = pbw__shifted(mantissa, exponent - (rows->faint >> k & 1 ? fine : unit), &lost);
                start[k] = i == count ? value : start[k];
                axis[k][i % count] = (pbw__digit)(int64_t)(value - start[k]);        /* [0] once more at the end */
            }
        }
        rows->spread = (pbw__column)1 << PBW__SMALL;
    }
    for (i = 0; i < count; i++) {                    /* compared as bits: equal weights need no work, in any mode */
        if (count > dim && pbw__bits(row[i][dim]) != pbw__bits(origin[dim])) {
            pbw__wrapped value[2];
            for (k = 0; k < 2; k++) {
                int shift = pbw__decode(k == 0 ? row[i][dim] : origin[dim], &mantissa) - 2 * unit;
                uint64_t low = pbw__shifted(mantissa, shift, &lost), ignored = 0;
                value[k] = (pbw__wrapped)pbw__shifted(mantissa, shift - 64, &ignored) << 32 << 32 | low;
            }
            rows->w[i] = (pbw__column)(value[0] - value[1]);
            rows->spread |= (rows->w[i] < 0 ? -rows->w[i] : rows->w[i]) >> PBW__SMALL;
        }
    }
    return lost == 0;
}

PBW__INLINE pbw__column pbw__times(pbw__digit a, pbw__digit b)
{
    return (pbw__column)a * b;
}

/* a = high R + low, 0 <= low < R; of small numbers low is all and high 0. */
PBW__INLINE pbw__digit pbw__low(int small, pbw__column a)
{
    return (pbw__digit)(small ? a : a & (((pbw__column)1 << PBW__DIGIT_BITS) - 1));
}

PBW__INLINE pbw__digit pbw__high(int small, pbw__column a)
{
    return small ? 0 : (pbw__digit)(a >> PBW__DIGIT_BITS);
}

PBW__INLINE pbw__column pbw__cross(const pbw__rows *u, int i, int j)
{
    return pbw__times(u->x[i], u->y[j]) - pbw__times(u->x[j], u->y[i]);
}

/* Stores high R + low as digits, the top one signed; returns the sign. */
PBW__INLINE int pbw__carry(pbw__column low, pbw__column high, pbw__digit *digit)
{
    high += pbw__high(0, low);
    digit[0] = pbw__low(0, low);
    digit[1] = pbw__low(0, high);
    digit[2] = pbw__high(0, high);
    return digit[2] < 0 ? -1 : (digit[0] | digit[1] | digit[2]) != 0;
}

PBW__INLINE int pbw__minor(int small, const pbw__rows *u, int i, int j, int k, pbw__digit *digit)
{
    pbw__column a = pbw__cross(u, j, k), b = pbw__cross(u, i, k), c = pbw__cross(u, i, j);
    return pbw__carry(pbw__times(u->z[i], pbw__low(small, a)) - pbw__times(u->z[j], pbw__low(small, b))
                                                              + pbw__times(u->z[k], pbw__low(small, c)),
                      pbw__times(u->z[i], pbw__high(small, a)) - pbw__times(u->z[j], pbw__high(small, b))
                                                               + pbw__times(u->z[k], pbw__high(small, c)), digit);
}

PBW__INLINE int pbw__integer_power(int dim, int small, int axes, const pbw__rows *u, int *orientation)
{
    pbw__digit minor[4][3];                          /* axes: bits of those in the lifts; bit 3: the weights */
    pbw__column column[4] = { 0, 0, 0, 0 };
    int i;
    if (dim == 2) {
        orientation[0] = pbw__carry(pbw__cross(u, 1, 2), 0, minor[0]);
        orientation[1] = -pbw__carry(pbw__cross(u, 0, 2), 0, minor[1]);
        orientation[2] = pbw__carry(pbw__cross(u, 0, 1), 0, minor[2]);
    } else {
        orientation[0] = pbw__minor(small, u, 1, 2, 3, minor[0]);
        orientation[1] = -pbw__minor(small, u, 0, 2, 3, minor[1]);
        orientation[2] = pbw__minor(small, u, 0, 1, 3, minor[2]);
        orientation[3] = -pbw__minor(small, u, 0, 1, 2, minor[3]);
    }
    for (i = 0; i <= dim; i++) {
        pbw__digit x = axes & 1 ? u->x[i] : 0, y = axes & 2 ? u->y[i] : 0, z = axes & 4 ? u->z[i] : 0, low, high;
        pbw__column lift = pbw__times(x, x) + pbw__times(y, y) + pbw__times(z, z) - (axes & 8 ? u->w[i] : 0);
        lift = i % 2 == 0 ? lift : -lift;
        low = pbw__low(small, lift);
        high = pbw__high(small, lift);
        column[0] += pbw__times(low, minor[i][0]);
        column[1] += pbw__times(low, minor[i][1]) + pbw__times(high, minor[i][0]);
        column[2] += pbw__times(low, minor[i][2]) + pbw__times(high, minor[i][1]);
        column[3] += pbw__times(high, minor[i][2]);
    }
    for (i = 0; i < 3; i++) {
        column[i + 1] += column[i] >> PBW__DIGIT_BITS;
        column[i] = pbw__low(0, column[i]);
    }
    return column[3] < 0 ? -1 : (column[0] | column[1] | column[2] | column[3]) != 0;
}

PBW__INLINE int pbw__integers_of(int dim, int count, const double *const *row, const double *origin,
                                 const pbw__grid *grid, int *orientation)
{
    pbw__rows u;
    pbw__digit det[3];
    if (!pbw__read_rows(dim, count, row, origin, grid, &u)) {
        return PBW__OPEN;
    }
    if (count > dim && u.faint != 0) {
        const int sign = pbw__integer_power(dim, 0, 15 - u.faint, &u, orientation);
        return sign != 0 ? sign : pbw__integer_power(dim, 0, u.faint, &u, orientation);
    }
    if (count > dim) {
        return u.spread >> PBW__SMALL == 0 ? pbw__integer_power(dim, 1, 15, &u, orientation)
                                           : pbw__integer_power(dim, 0, 15, &u, orientation);
    }
    return dim == 2 ? pbw__carry(pbw__cross(&u, 0, 1), 0, det) : -pbw__minor(0, &u, 0, 1, 2, det);
}

PBW__DEVICE static int pbw__integers(int dim, int count, const double *const *row, const double *origin,
                                     const pbw__grid *grid, int *orientation)
{
    return dim == 2 ? pbw__integers_of(2, count, row, origin, grid, orientation)
                    : pbw__integers_of(3, count, row, origin, grid, orientation);
}

/* ---- pairs
   Pair arithmetic (Lange and Rump 2020, "Faithfully rounded floating-point computations", ACM TOMS 46(3)): head and
   tail without renormalisation.  Let a quantity x be at most m, a sum of absolute products, and |tail| <= K u m,
   |head + tail - x| <= E u^2 m, u = 2^-53.  Two-sum (Knuth 1969) and two-product (Dekker 1971) are exact, so

      a * b   K = 1 + Ka + Kb,      E = Ea + Eb + Ka Kb + 3 (Ka + Kb) + 1     tail: e + (ha tb + ta hb), no ta tb
      a + b   K = 1 + max(Ka, Kb),  E = max(Ea, Eb) + 2 max(Ka, Kb) + 1       tail: e + (ta + tb);  m = ma + mb

   to leading order, and step by step

                              K    E                              K    E
      difference of doubles   1    0      |u|^2 - dw, plane       5   24
      product of two          3    8      |u|^2 - dw, space       6   35
      cross                   4   15      orient2    15 *  2 =   30 u^2 mx my
      z cross                 6   35
      minor, sum of 3         8   63      orient3    63 *  6 =  378 u^2 mx my mz
      lift cross             10   87
      sum of 3               12  131      power2    131 *  6 =  786 u^2 mx my ml
      lift minor             15  189
      sum of 4               17  253      power3    253 * 24 = 6072 u^2 mx my mz ml
      the kernels' circle    11  120      circle    120 *  6 =  720 u^2 h^2
      the kernels' sphere    17  288      sphere    288 * 24 = 6912 u^2 h^(5/2)

   One value here must not be fused into a sum, the head of a product.  Where there are fused operations it is made by
   one that adds 0.0, which is no multiplication for a compiler (-0.0 + 0.0 is not -0.0), so that neither clang's
   -ffp-contract=fast, which overrides all pragmas, nor gcc's vfmaddsub can touch it.  Other fusions only save a
   rounding, which the bounds allow. */
PBW__INLINE pbw_pair pbw__pair_plus(pbw_pair a, pbw_pair b)
{
    pbw_pair result = pbw_two_sum(a.head, b.head);
    result.tail = result.tail + (a.tail + b.tail);
    return result;
}

PBW__INLINE pbw_pair pbw__pair_minus(pbw_pair a, pbw_pair b)
{
    b.head = -b.head;
    b.tail = -b.tail;
    return pbw__pair_plus(a, b);
}

PBW__INLINE pbw_pair pbw__pair_difference(double a, double b)
{
    pbw_pair x = { a, 0.0 }, y = { b, 0.0 };
    return pbw__pair_minus(x, y);
}

PBW__INLINE pbw_pair pbw__pair_times(pbw_pair a, pbw_pair b)
{
    pbw_pair result = pbw_two_product(a.head, b.head);
    result.tail = result.tail + (a.head * b.tail + a.tail * b.head);
    return result;
}

/* a0 b0 - a1 b1 + a2 b2, of minors by rows or of lifts with minors. */
PBW__INLINE pbw_pair pbw__pair_sum(pbw_pair a0, pbw_pair b0, pbw_pair a1, pbw_pair b1,
                                    pbw_pair a2, pbw_pair b2)
{
    return pbw__pair_plus(pbw__pair_minus(pbw__pair_times(a0, b0), pbw__pair_times(a1, b1)), pbw__pair_times(a2, b2));
}

PBW__INLINE pbw_pair pbw__pair_cross(pbw_pair (*u)[4], int i, int j)
{
    return pbw__pair_minus(pbw__pair_times(u[0][i], u[1][j]), pbw__pair_times(u[0][j], u[1][i]));
}

PBW__INLINE pbw_pair pbw__pair_minor(pbw_pair (*u)[4], int i, int j, int k)
{
    return pbw__pair_sum(u[2][i], pbw__pair_cross(u, j, k), u[2][j], pbw__pair_cross(u, i, k),
                         u[2][k], pbw__pair_cross(u, i, j));
}

/* Multiplies by a power of two. */
PBW__INLINE pbw_pair pbw__pair_scaled(pbw_pair a, double scale)
{
    a.head *= scale;
    a.tail *= scale;
    return a;
}

/* Scales by powers of two change no sign: u[axis][row] has each axis by its own, so that its largest number is below
   1 and at least 2^-52 (of denormals); v, for lifts, all axes by one.  What underflows, of u, v or weights, is below
   2^-1020 beside a bound above 2^-370. */
PBW__DEVICE static int pbw__pairs(int dim, int count, const double *const *row, const double *origin)
{
    pbw_pair u[3][4], v[3][4], lift[4], det;
    double low = 1e100, high = 0.0, size = PBW__EPSILON * PBW__EPSILON, scale;
    int i, k;
    for (k = 0; k < dim; k++) {
        double largest = 0.0;
        for (i = 0; i < count; i++) {
            v[k][i] = pbw__pair_difference(row[i][k], origin[k]);
            largest = pbw__max(largest, pbw__abs(v[k][i].head));
        }
        high = pbw__max(high, largest);
        scale = pbw__power_of_two(-pbw__exponent(largest));
        for (i = 0; i < count; i++) {
            u[k][i] = pbw__pair_scaled(v[k][i], scale);
        }
        largest *= scale;
        low = largest < low ? largest : low;
        size *= largest;
    }
    if (count == dim) {
        det = dim == 2 ? pbw__pair_cross(u, 0, 1) : pbw__pair_minor(u, 0, 2, 1);
        return pbw__certain(det.head + det.tail,
                            (dim == 2 ? PBW__PAIRS_ORIENT2_ERROR : PBW__PAIRS_ORIENT3_ERROR) * size, low, size);
    }
    scale = pbw__power_of_two(-pbw__exponent(high));
    for (high = 0.0, i = 0; i < count; i++) {
        pbw_pair weight = pbw__pair_difference(row[i][dim], origin[dim]);
        weight = pbw__pair_scaled(pbw__pair_scaled(weight, scale), scale);
        for (k = 0; k < dim; k++) {
            v[k][i] = pbw__pair_scaled(v[k][i], scale);
        }
        lift[i] = pbw__pair_plus(pbw__pair_times(v[0][i], v[0][i]), pbw__pair_times(v[1][i], v[1][i]));
        if (dim == 3) {
            lift[i] = pbw__pair_plus(lift[i], pbw__pair_times(v[2][i], v[2][i]));
        }
        high = pbw__max(high, lift[i].head + pbw__abs(weight.head));
        lift[i] = pbw__pair_minus(lift[i], weight);
    }
    size *= high;
    if (dim == 2) {
        det = pbw__pair_sum(lift[0], pbw__pair_cross(u, 1, 2), lift[1], pbw__pair_cross(u, 0, 2),
                            lift[2], pbw__pair_cross(u, 0, 1));
        return pbw__certain(det.head + det.tail, PBW__PAIRS_POWER2_ERROR * size, low, high);
    }
    det = pbw__pair_plus(pbw__pair_minus(pbw__pair_times(lift[0], pbw__pair_minor(u, 1, 2, 3)),
                                         pbw__pair_times(lift[1], pbw__pair_minor(u, 0, 2, 3))),
                         pbw__pair_minus(pbw__pair_times(lift[2], pbw__pair_minor(u, 0, 1, 3)),
                                         pbw__pair_times(lift[3], pbw__pair_minor(u, 0, 1, 2))));
    return pbw__certain(det.head + det.tail, PBW__PAIRS_POWER3_ERROR * size, low, high);
}

/* ---- the ladder below the filter */
/* Returns the sign of an orientation, or of a power determinant, which has a row more, if there is room for
   orientations, which are filled where the sign is 0.  pool: room for the digits of the last stage; without it that
   stage is left out, and the sign may be open. */
PBW__DEVICE static PBW__NOINLINE int pbw__undecided_in(pbw__digit *pool, int dim, const double *const *row,
                                                       const double *origin, const pbw__grid *grid, int *orientation)
{
    const int count = dim + (orientation != NULL);
    int sign = pbw__integers(dim, count, row, origin, grid, orientation), i, k;
    for (k = 0; k < dim && sign == PBW__OPEN && orientation == NULL; k++) { /* no differences along an axis: 0 */
        for (i = 0; i < dim && pbw__bits(row[i][k]) == pbw__bits(origin[k]); i++) {
        }
        sign = i == dim ? 0 : PBW__OPEN;
    }
    if (sign == PBW__OPEN && grid != NULL) {
        sign = pbw__pairs(dim, count, row, origin);
    }
    return sign != PBW__OPEN || pool == NULL ? sign
         : pbw__exact_determinant_in(pool, dim, count, row, origin, orientation);
}

/* The last stage, in a frame of its own: compilers may touch each page of a large frame at each call. */
static PBW__NOINLINE int pbw__last_stage(int dim, const double *const *row, const double *origin, int *orientation)
{
    pbw__digit pool[PBW__POOL];
    return pbw__exact_determinant_in(pool, dim, dim + (orientation != NULL), row, origin, orientation);
}

/* pbw__undecided_in, but the sign is never open. */
static PBW__NOINLINE int pbw__undecided(int dim, const double *const *row, const double *origin,
                                        const pbw__grid *grid, int *orientation)
{
    const int sign = pbw__undecided_in(NULL, dim, row, origin, grid, orientation);
    return sign != PBW__OPEN ? sign : pbw__last_stage(dim, row, origin, orientation);
}

/* The verdict on a tie, a power determinant of 0.
   Lifts are raised by infinitesimals, that of the lexicographically largest point dominating (Devillers and Teillaud
   2011).  In sum_i lift_i * orientation_i corner i's own lift has the coefficient orientation_i, and p's own has
   -sum_i orientation_i, minus the orientation of the simplex: negative.  So the largest point that has a coefficient
   decides by its sign, and if that is p the answer is no.  There always is one, p at the latest; it is unique, since
   the places differ; and weights change lifts only, so they add no other case. */
PBW__DEVICE static int pbw__tie(int dim, const double *const *row, const double *p, const int *orientation)
{
    const double *largest = p;
    int i, k, verdict = 0;
    for (i = 0; i <= dim; i++) {
        if (orientation[i] != 0) {
            for (k = 0; k < dim - 1 && row[i][k] == largest[k]; k++) {
            }
            if (row[i][k] > largest[k]) {
                largest = row[i];
                verdict = orientation[i] > 0;
            }
        }
    }
    return verdict;
}

PBW__INLINE int pbw__filter_orient(int dim, const double *const *x)
{
    return dim == 2 ? pbw__filter_orient2(x[0], x[1], x[2]) : pbw__filter_orient3(x[0], x[1], x[2], x[3]);
}

/* Returns the orientation of the simplex x[0..dim]. */
PBW__INLINE int pbw__orient(int dim, const double *const *x, const pbw__grid *grid)
{
    const int sign = pbw__filter_orient(dim, x);
    return PBW__LIKELY(sign != PBW__OPEN) ? sign : pbw__undecided(dim, x, x[dim], grid, NULL);
}

/* Returns the orientation with p in place of corner i: the side of the facet across from it, +1 inside. */
static int pbw__side(int dim, const double **x, int i, const double *p, const pbw__grid *grid)
{
    const double *corner = x[i];
    int sign;
    x[i] = p;
    sign = pbw__orient(dim, x, grid);
    x[i] = corner;
    return sign;
}

PBW__INLINE int pbw__filter_power(int dim, const double *const *x, const double *p)
{
    return dim == 2 ? pbw__filter_power2(x[0], x[1], x[2], p) : pbw__filter_power3(x[0], x[1], x[2], x[3], p);
}

static int pbw__power(int dim, const double *const *x, const double *p, const pbw__grid *grid)
{
    int orientation[4], sign = pbw__filter_power(dim, x, p);
    return PBW__LIKELY(sign != PBW__OPEN) ? sign : pbw__undecided(dim, x, p, grid, orientation);
}

/* Returns the perturbed verdict on a positive simplex and a point that is none of its corners: 1 for conflict. */
static int pbw__conflict(int dim, const double *const *x, const double *p, const pbw__grid *grid)
{
    int orientation[4], sign = pbw__filter_power(dim, x, p);
    if (PBW__LIKELY(sign != PBW__OPEN)) {
        return sign > 0;
    }
    sign = pbw__undecided(dim, x, p, grid, orientation);
    return sign != 0 ? sign > 0 : pbw__tie(dim, x, p, orientation);
}

/* Returns whether the points a, b, c of space lie on a line: all three projections do. */
static int pbw__collinear3(const double *a, const double *b, const double *c, const pbw__grid *grid)
{
    int collinear = 1, k;
    for (k = 0; k < 3 && collinear; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        double pa[2] = { a[i], a[j] }, pb[2] = { b[i], b[j] }, pc[2] = { c[i], c[j] };
        const double *x[3] = { pa, pb, pc };
        collinear = pbw__orient(2, x, grid) == 0;
    }
    return collinear;
}

/* pbw__orient and pbw__conflict with the caller's room for digits, or none: see pbw__undecided_in. */
PBW__INLINE int pbw__orient_in(pbw__digit *pool, int dim, const double *const *x, const pbw__grid *grid)
{
    const int sign = pbw__filter_orient(dim, x);
    return PBW__LIKELY(sign != PBW__OPEN) ? sign : pbw__undecided_in(pool, dim, x, x[dim], grid, NULL);
}

PBW__INLINE int pbw__conflict_in(pbw__digit *pool, int dim, const double *const *x, const double *p,
                                 const pbw__grid *grid)
{
    int orientation[4], sign = pbw__filter_power(dim, x, p);
    if (PBW__UNLIKELY(sign == PBW__OPEN)) {
        sign = pbw__undecided_in(pool, dim, x, p, grid, orientation);
    }
    return sign == PBW__OPEN ? PBW__OPEN : sign != 0 ? sign > 0 : pbw__tie(dim, x, p, orientation);
}

/* ---- for callers from outside */
PBWDEF int pbw_orient2(const double a[2], const double b[2], const double c[2])
{
    const double *x[3] = { a, b, c };
    return pbw__orient(2, x, NULL);
}

PBWDEF int pbw_orient3(const double a[3], const double b[3], const double c[3], const double d[3])
{
    const double *x[4] = { a, b, c, d };
    return pbw__orient(3, x, NULL);
}

/* Returns the sign for corners and p, the last point, with their weights or NULL; `tied`: the perturbed verdict. */
static int pbw__power_of(int dim, const double *const *point, const double *weight, int tied)
{
    double q[5][4];
    const double *x[5];
    int i;
    for (i = 0; i < dim + 2; i++) {
        memcpy(q[i], point[i], (size_t)dim * sizeof(double));
        q[i][dim] = weight != NULL ? weight[i] : 0.0;
        x[i] = q[i];
    }
    return tied ? pbw__conflict(dim, x, x[dim + 1], NULL) : pbw__power(dim, x, x[dim + 1], NULL);
}

PBWDEF int pbw_power2(const double a[2], const double b[2], const double c[2], const double p[2], const double w[4])
{
    const double *point[4] = { a, b, c, p };
    return pbw__power_of(2, point, w, 0);
}

PBWDEF int pbw_incircle(const double a[2], const double b[2], const double c[2], const double p[2])
{
    return pbw_power2(a, b, c, p, NULL);
}

PBWDEF int pbw_power3(const double a[3], const double b[3], const double c[3], const double d[3], const double p[3],
                      const double w[5])
{
    const double *point[5] = { a, b, c, d, p };
    return pbw__power_of(3, point, w, 0);
}

PBWDEF int pbw_insphere(const double a[3], const double b[3], const double c[3], const double d[3], const double p[3])
{
    return pbw_power3(a, b, c, d, p, NULL);
}

PBWDEF int pbw_conflict2(const double a[2], const double b[2], const double c[2], const double p[2],
                         const double w[4])
{
    const double *point[4] = { a, b, c, p };
    return pbw__power_of(2, point, w, 1);
}

PBWDEF int pbw_conflict3(const double a[3], const double b[3], const double c[3], const double d[3],
                         const double p[3], const double w[5])
{
    const double *point[5] = { a, b, c, d, p };
    return pbw__power_of(3, point, w, 1);
}
/* ------------------------------------------------------------------------------------------------------
   >>curve        Points, and their keys on a Hilbert curve.
   In: the caller's points and weights, and a box.  Out: their records; the key of a point: the number of its cell in
   the box's grid, along the curve.
   ------------------------------------------------------------------------------------------------------ */
#define PBW__POINT_LIMIT ((size_t)1 << 31)           /* the highest bit of a vertex is free for marks of >>cavity2 */

typedef struct pbw__input {
    int dim, is_float, borrow, bare;                 /* bare: no two points are at one place, and only their order is
                                                        wanted, so no records are made and no duplicates found */
    int padded;                                      /* records have a weight even if the points have none */
    size_t count, stride, weight_stride, last;       /* last: bytes of a point before its last coordinate */
    const char *points, *weights;
} pbw__input;

static pbw__input pbw__input_of(int dim, int is_float, const void *points, const void *weights, size_t count)
{
    const size_t at = ((size_t)dim - 1) * (is_float ? sizeof(float) : sizeof(double));
    const pbw__input input = { dim, is_float, 0, 0, 0, count, 0, 0, at, (const char *)points, (const char *)weights };
    return input;
}

/* Checks the arguments of a call, and takes the rest of the input from the options.  A borrowed array must be one
   that the mesh could have made. */
static pbw_status pbw__input_check(pbw__input *input, const pbw_options *options)
{
    const size_t size = input->is_float ? sizeof(float) : sizeof(double), packed = (size_t)input->dim * size;
    const unsigned all = PBW_ANY_ORDER | PBW_NO_NEIGHBORS | PBW_BACKEND_OR_CPU | PBW_CURVE_ORDER | PBW_BORROW;
    const size_t count = input->count;
    input->borrow = (options->flags & PBW_BORROW) != 0;
    input->stride = options->stride != 0 ? options->stride : packed;
    input->weight_stride = options->weight_stride != 0 ? options->weight_stride : size;
    if ((input->dim != 2 && input->dim != 3) || (input->points == NULL && count != 0)
        || options->threads < 0 || options->threads > 256
        || (options->flags & ~all) != 0 || input->stride < packed || input->weight_stride < size
        || (input->borrow && (input->is_float || input->stride != packed
                              || (input->weights != NULL && input->weight_stride != size)
                              || (options->flags & PBW_CURVE_ORDER) != 0))) {
        return PBW_ERROR_ARGUMENT;
    }
    if (count >= PBW__POINT_LIMIT || count > (size_t)-1 / input->stride || count > (size_t)-1 / input->weight_stride
        || count > (size_t)-1 / 256) {
        return PBW_ERROR_TOO_LARGE;
    }
    return PBW_OK;
}

/* Reads coordinates and, if there are weights, the weight of point i; adding zero turns -0.0 into 0.0.  By memcpy, as
   strides may have any alignment; with a constant size it is no call. */
PBW__INLINE void pbw__fetch_place(const pbw__input *input, size_t i, double *record, int dim)
{
    const char *point = input->points + i * input->stride;
    int k;
    if (input->is_float) {
        float f[3];
        memcpy(f, point, (size_t)dim * sizeof(float));
        for (k = 0; k < dim; k++) {
            record[k] = (double)f[k] + 0.0;
        }
        if (input->weights != NULL) {
            memcpy(f, input->weights + i * input->weight_stride, sizeof(float));
            record[dim] = (double)f[0] + 0.0;
        }
    } else {
        memcpy(record, point, (size_t)dim * sizeof(double));
        for (k = 0; k < dim; k++) {
            record[k] += 0.0;
        }
        if (input->weights != NULL) {
            memcpy(record + dim, input->weights + i * input->weight_stride, sizeof(double));
            record[dim] += 0.0;
        }
    }
}

/* Reads point i with a weight, zero if there are none. */
PBW__INLINE void pbw__fetch_of(const pbw__input *input, size_t i, double *record, int dim)
{
    record[dim] = 0.0;
    pbw__fetch_place(input, i, record, dim);
}

PBW__INLINE void pbw__fetch(const pbw__input *input, size_t i, double *record)
{
    PBW__BY_DIM(input->dim, pbw__fetch_of, input, i, record);
}

/* Prefetches point i, which may lie in two cache lines. */
PBW__INLINE void pbw__fetch_soon(const pbw__input *input, size_t i)
{
    const char *point = input->points + i * input->stride;
    PBW__PREFETCH(point);
    PBW__PREFETCH(point + input->last);
    if (input->weights != NULL) {
        PBW__PREFETCH(input->weights + i * input->weight_stride);
    }
}

/* Hilbert curve, as an automaton (Hamilton & Rau-Chaplin 2008, "Compact Hilbert indices"): entry [state][octant],
   where bit k of the octant is the next bit of coordinate k, holds next state * 2^dim + next digit of the key. */
static const unsigned char pbw__hilbert2[4][4] = {
    { 4, 11, 1, 2 }, { 0, 5, 15, 6 }, { 10, 3, 9, 12 }, { 14, 13, 7, 8 }
};
static const unsigned char pbw__hilbert3[12][8] = {
    { 8, 23, 25, 38, 43, 44, 26, 37 },  { 24, 51, 63, 52, 1, 2, 70, 69 },   { 76, 39, 75, 80, 5, 6, 66, 65 },
    { 0, 9, 83, 10, 95, 78, 84, 77 },   { 22, 7, 21, 60, 49, 88, 50, 59 },  { 58, 85, 3, 4, 57, 86, 72, 55 },
    { 90, 89, 45, 46, 11, 32, 12, 87 }, { 36, 13, 71, 14, 35, 74, 40, 73 }, { 62, 81, 15, 16, 61, 82, 92, 91 },
    { 94, 93, 41, 42, 31, 20, 56, 19 }, { 18, 27, 17, 64, 53, 28, 54, 47 }, { 68, 67, 29, 34, 79, 48, 30, 33 }
};

#define PBW__LEVELS2 5
#define PBW__LEVELS3 3
#define PBW__LEVELS_TABLE 1024                       /* of one level less: at least 4 << 8 and 12 << 6 */

/* Several levels of the automaton in one step: entry state << dim*levels | octants holds next state << dim*levels |
   digits of the key, for the next `levels` octants. */
typedef struct pbw__curve {
    int levels;                                      /* 0: no table yet; 1 for few points: more would not pay */
    uint16_t step[12 << 3 * PBW__LEVELS3];
} pbw__curve;

static void pbw__curve_create(pbw__curve *curve, size_t count, int dim)
{
    const unsigned states = dim == 3 ? 12 : 4;
    uint16_t fewer[PBW__LEVELS_TABLE];               /* the same for one level less */
    unsigned entry, level;
    curve->levels = count < PBW__SMALLER(3000) ? 1 : dim == 3 ? PBW__LEVELS3 : PBW__LEVELS2;
    for (level = 0; level < (unsigned)curve->levels; level++) {      /* one more level, above the others */
        const unsigned low = (unsigned)dim * level, width = low + (unsigned)dim;
        memcpy(fewer, curve->step, (level > 0 ? states << low : 0) * sizeof(fewer[0]));
        for (entry = 0; entry < states << width; entry++) {
            const unsigned octant = entry >> low & ((1u << dim) - 1), rest = entry & ((1u << low) - 1);
            const unsigned char *state = dim == 3 ? pbw__hilbert3[entry >> width] : pbw__hilbert2[entry >> width];
            const unsigned step = state[octant], next = level > 0 ? fewer[step >> dim << low | rest] : step >> dim;
            curve->step[entry] = (uint16_t)(next >> low << width | (step & ((1u << dim) - 1)) << low
                                            | (next & ((1u << low) - 1)));
        }
    }
}

/* A box and its cubic grid of 2^bits cells along the longest side, in coordinates scaled by 1, or by 1/2 where the
   longest side would overflow. */
typedef struct pbw__box {
    double low[3], high[3], scale, extent;
    int bits;
} pbw__box;

/* Returns the bits of an index below count. */
static int pbw__index_bits(size_t count)
{
    int bits;
    for (bits = 1; bits < 32 && ((uint64_t)count - 1) >> bits != 0; bits++) {
    }
    return bits;
}

/* Returns the bits of a coordinate in a key.  A grid of 2^index_bits cells a side has more cells on any line through
   it than there are points. */
static int pbw__grid_bits(int index_bits, int dim)
{
    int bits = index_bits > 10 ? index_bits : 10, most = (64 - index_bits) / dim;
    return bits < most ? bits : most;
}

PBW__DEVICE static void pbw__box_reset(pbw__box *box, int bits)
{
    int k;
    for (k = 0; k < 3; k++) {
        box->low[k] = DBL_MAX;
        box->high[k] = -DBL_MAX;
    }
    box->bits = bits;
}

PBW__INLINE void pbw__box_add(pbw__box *box, const double *x, int dim)
{
    int k;
    for (k = 0; k < dim; k++) {
        box->low[k] = x[k] < box->low[k] ? x[k] : box->low[k];
        box->high[k] = x[k] > box->high[k] ? x[k] : box->high[k];
    }
}

/* The extent is 0 if all points are equal; else the lowest and the highest point of the longest side get different
   cells. */
PBW__DEVICE static void pbw__box_close(pbw__box *box, int dim)
{
    int k;
    for (box->scale = 1.0; ; box->scale = 0.5) {
        box->extent = 0.0;
        for (k = 0; k < dim; k++) {
            double side = box->scale * box->high[k] - box->scale * box->low[k];
            box->extent = side > box->extent ? side : box->extent;
        }
        if (box->extent <= DBL_MAX) {
            return;
        }
    }
}

/* Spreads the bits of x dim places apart: first its halves, then the halves of those. */
PBW__INLINE uint64_t pbw__spread(uint64_t x, int dim)
{
    const int space = dim == 3;
    x = (x | x << (16 << space)) & (space ? 0x1f00000000ffffu : 0xffff0000ffffu);
    x = (x | x << (8 << space)) & (space ? 0x1f0000ff0000ffu : 0xff00ff00ff00ffu);
    x = (x | x << (4 << space)) & (space ? 0x100f00f00f00f00fu : 0xf0f0f0f0f0f0f0fu);
    x = (x | x << (2 << space)) & (space ? 0x10c30c30c30c30c3u : 0x3333333333333333u);
    return (x | x << (1 << space)) & (space ? 0x1249249249249249u : 0x5555555555555555u);
}

/* steps, levels: the curve's; levels as a constant.  The first step is filled up with zeros; it starts in the state
   from which they lead to state 0. */
PBW__INLINE uint64_t pbw__hilbert_key(const uint16_t *steps, const pbw__box *box, const double *x, int dim,
                                      int levels)
{
    const int width = dim * levels, bits = (box->bits + levels - 1) / levels * levels, fill = bits - box->bits;
    const uint32_t last = ((uint32_t)1 << box->bits) - 1;
    const unsigned digits = (1u << width) - 1;
    unsigned state = (unsigned)(dim == 2 ? fill & 1 : fill == 0 ? 0 : fill == 1 ? 3 : 1) << width;
    uint64_t cells = 0, key = 0;                     /* cells: the octants of all levels */
    int k, at;
    for (k = 0; k < dim; k++) {
        double t = (box->scale * x[k] - box->scale * box->low[k]) / box->extent * (double)(last + 1);
        cells |= pbw__spread(t < (double)last ? (uint32_t)t : last, dim) << k;
    }
    for (at = bits * dim - width; at >= 0; at -= width) {
        const unsigned step = steps[state | ((unsigned)(cells >> at) & digits)];
        key = key << width | (step & digits);
        state = step & ~digits;
    }
    return key;
}

#ifdef PBW__AVX2
/* Eight keys at once, in the plane, where the automaton is a formula.  Of the next bits x and y of the coordinates
   let u = x ^ y; of state s let c = s >> 1, a = (s & 1) ^ c.  Then the table says: the digit is x ^ ((a ^ c) & u) ^ c
   and u after it; if u = 0 the next a is a ^ c ^ !x, if u = 1 the next c is c ^ a ^ x, and the other stays.  Over
   bits that is affine: a' = m00 a + m01 c + ta, c' = m10 a + m11 c + tc.  So are several levels in a row; all that
   come before a level are made of 1, 2, 4, ... of them, for all bits of a word at once (Kogge & Stone 1973).
   The first state is 0.  n00 and n11 are m00 and m11 inverted: so the zeros that shifts bring in change nothing. */
typedef uint32_t pbw__u8 __attribute__((vector_size(32)));

/* Returns the cells of coordinate k of eight points, as in pbw__hilbert_key. */
PBW__SIMD_INLINE pbw__u8 pbw__cells8(const pbw__box *box, int k, pbw__d4 x0, pbw__d4 x1)
{
    const double last = (double)(((uint32_t)1 << box->bits) - 1);
    const pbw__d4 scale = pbw__splat(box->scale), low = scale * pbw__splat(box->low[k]);
    const pbw__d4 cells = pbw__splat(last + 1.0), extent = pbw__splat(box->extent), most = pbw__splat(last);
    const __m128i first = _mm256_cvttpd_epi32(_mm256_min_pd((scale * x0 - low) / extent * cells, most));
    const __m128i second = _mm256_cvttpd_epi32(_mm256_min_pd((scale * x1 - low) / extent * cells, most));
    return (pbw__u8)_mm256_inserti128_si256(_mm256_castsi128_si256(first), second, 1);
}

typedef struct pbw__levels8 { pbw__u8 n00, m01, m10, n11, ta, tc; } pbw__levels8;

/* For each bit, composes the `count` levels that end there with the `count` levels before them. */
PBW__SIMD_INLINE void pbw__levels_join(pbw__levels8 *levels, int count)
{
    const pbw__levels8 m = *levels;
    const pbw__u8 n00 = m.n00 >> count, m01 = m.m01 >> count, m10 = m.m10 >> count, n11 = m.n11 >> count;
    const pbw__u8 ta = m.ta >> count, tc = m.tc >> count;
    levels->n00 = (m.n00 | n00) ^ (m.m01 & m10);
    levels->m01 = (~m.n00 & m01) ^ (m.m01 & ~n11);
    levels->m10 = (m.m10 & ~n00) ^ (~m.n11 & m10);
    levels->n11 = (m.n11 | n11) ^ (m.m10 & m01);
    levels->ta = m.ta ^ (~m.n00 & ta) ^ (m.m01 & tc);
    levels->tc = m.tc ^ (m.m10 & ta) ^ (~m.n11 & tc);
}

/* Returns the first bits of all digits, the second being x ^ y; `all`: the bits that the coordinates have. */
PBW__SIMD_INLINE pbw__u8 pbw__digits8(pbw__u8 x, pbw__u8 y, uint32_t all)
{
    const pbw__u8 u = x ^ y, zero = u ^ u;
    pbw__levels8 before = { zero, u ^ all, u, zero, ~(x | y) & all, x & ~y };
    pbw__levels_join(&before, 1);
    pbw__levels_join(&before, 2);
    pbw__levels_join(&before, 4);
    pbw__levels_join(&before, 8);
    pbw__levels_join(&before, 16);
    return x ^ (((before.ta ^ before.tc) >> 1) & u) ^ (before.tc >> 1);
}

/* Puts a zero before each bit of four numbers: by bytes, then by halves of bytes. */
PBW__SIMD_INLINE __m256i pbw__spread4(__m128i x)
{
    const __m256i table = _mm256_setr_epi8(0, 1, 4, 5, 16, 17, 20, 21, 64, 65, 68, 69, 80, 81, 84, 85,
                                           0, 1, 4, 5, 16, 17, 20, 21, 64, 65, 68, 69, 80, 81, 84, 85);
    const __m256i bytes = _mm256_cvtepu8_epi16(x), halves = _mm256_or_si256(bytes, _mm256_slli_epi16(bytes, 4));
    return _mm256_shuffle_epi8(table, _mm256_and_si256(halves, _mm256_set1_epi8(15)));
}

PBW__SIMD_INLINE __m256i pbw__interleave4(__m128i first, __m128i second)
{
    const __m256i spread = pbw__spread4(first);
    return _mm256_or_si256(_mm256_add_epi64(spread, spread), pbw__spread4(second));
}
#endif
/* ------------------------------------------------------------------------------------------------------
   >>sort         Keys in ascending order: a radix sort by several threads.
   In: keys of 64 bits.  Out: the keys, ordered by some of their bits; keys of equal bits keep their order.
   A pass sorts by one digit: each task counts the digits of its share of the keys, then moves the keys behind all of
   lower digits, and behind those of the same digit in earlier shares.
   ------------------------------------------------------------------------------------------------------ */
#define PBW__DIGITS 2048

typedef struct pbw__sorting {
    pbw__context *context;
    uint64_t *a, *b;                                 /* count keys; room for count keys */
    uint32_t *start;                                 /* PBW__DIGITS words a task, and once more for all tasks */
    size_t count;
    int tasks;                                       /* of which at most one for each thread is used */
    int shift, digit;                                /* of this pass */
} pbw__sorting;

static void pbw__count_digits(void *arg, int task)
{
    const pbw__sorting *sorting = (const pbw__sorting *)arg;
    const uint64_t *a = sorting->a, mask = ((uint64_t)1 << sorting->digit) - 1;
    uint32_t *start = sorting->start + (size_t)task * PBW__DIGITS;
    size_t i = pbw__share(sorting->count, task, sorting->tasks);
    size_t to = pbw__share(sorting->count, task + 1, sorting->tasks), end;
    memset(start, 0, ((size_t)mask + 1) * sizeof(start[0]));
    for (; i < to; i = end) {
        for (end = to - i < PBW__TICK ? to : i + PBW__TICK; i < end; i++) {
            PBW__PREFETCH_STREAM(a, i, to);
            start[(a[i] >> sorting->shift) & mask]++;
        }
        if (sorting->count > PBW__TICK && pbw__report(sorting->context, 0.5)) {
            return;
        }
    }
}

static void pbw__move_keys(void *arg, int task)
{
    const pbw__sorting *sorting = (const pbw__sorting *)arg;
    const uint64_t *a = sorting->a, mask = ((uint64_t)1 << sorting->digit) - 1;
    uint64_t *b = sorting->b;
    uint32_t *start = sorting->start + (size_t)task * PBW__DIGITS;
    const uint32_t *before = sorting->start + (size_t)sorting->tasks * PBW__DIGITS;
    const size_t line = 64 / sizeof(b[0]);           /* prefetch the next line of this digit */
    size_t i, to = pbw__share(sorting->count, task + 1, sorting->tasks), end;
    for (i = 0; i <= mask; i++) {
        start[i] += before[i];
    }
    for (i = pbw__share(sorting->count, task, sorting->tasks); i < to; i = end) {
        for (end = to - i < PBW__TICK ? to : i + PBW__TICK; i < end; i++) {
            size_t place = start[(a[i] >> sorting->shift) & mask]++;
            PBW__PREFETCH_STREAM(a, i, to);
            PBW__PREFETCH_TO_WRITE(b + (place + line < sorting->count ? place + line : place));
            b[place] = a[i];
        }
        if (sorting->count > PBW__TICK && pbw__report(sorting->context, 0.5)) {
            return;
        }
    }
}

/* Sorts the keys by `bits` bits from `low` on.  Returns the array with the result, a or b, or NULL if cancelled.
   With more than one task a thread, each has so few keys of a digit that threads falsely share cache lines. */
static uint64_t *pbw__sort_by(pbw__sorting *sorting, int low, int bits)
{
    pbw__context *context = sorting->context;
    const int tasks = sorting->tasks < context->threads ? sorting->tasks : context->threads;
    const int widest = sorting->count < 1024 ? 9 : 11, passes = (bits + widest - 1) / widest;
    uint32_t *all = sorting->start + (size_t)tasks * PBW__DIGITS;
    int task;
    sorting->tasks = tasks;
    sorting->digit = (bits + passes - 1) / passes;
    for (sorting->shift = low; sorting->shift < low + bits; sorting->shift += sorting->digit) {
        size_t size = (size_t)1 << sorting->digit, i;
        uint32_t sum = 0;
        uint64_t *swap = sorting->a;
        pbw__for(context, tasks, pbw__count_digits, sorting);
        memset(all, 0, size * sizeof(all[0]));
        for (task = 0; task < tasks; task++) {       /* counts to places: within each digit, then of digits */
            uint32_t *own = sorting->start + (size_t)task * PBW__DIGITS;
            for (i = 0; i < size; i++) {
                uint32_t here = own[i];
                own[i] = all[i];
                all[i] += here;
            }
        }
        for (i = 0; i < size; i++) {
            uint32_t here = all[i];
            all[i] = sum;
            sum += here;
        }
        if (PBW__LOAD(&context->cancelled)) {
            return NULL;
        }
        pbw__for(context, tasks, pbw__move_keys, sorting);
        if (PBW__LOAD(&context->cancelled)) {
            return NULL;
        }
        sorting->a = sorting->b;
        sorting->b = swap;
    }
    return sorting->a;
}

/* pbw__sort_by on the calling thread alone; few keys by insertion.  Keys have equal bits above the sorted ones. */
static uint64_t *pbw__sort_keys(pbw__sorting *sorting, int low, int bits)
{
    uint32_t start[2 * PBW__DIGITS];
    uint64_t *a = sorting->a;
    size_t i, hole;
    if (sorting->count >= 64) {
        sorting->start = start;
        sorting->tasks = 1;
        return pbw__sort_by(sorting, low, bits);
    }
    for (i = 1; i < sorting->count; i++) {
        const uint64_t moving = a[i];
        for (hole = i; hole > 0 && a[hole - 1] >> low > moving >> low; hole--) {
            a[hole] = a[hole - 1];
        }
        a[hole] = moving;
    }
    return a;
}
/* ------------------------------------------------------------------------------------------------------
   >>order        Points in the order of a Hilbert curve, duplicates set aside.
   In: the caller's points and weights.  Out: vertex records 1..vertex_count along the curve, of coordinates and, if
   there are weights, a weight (record 0 stands for the ghost vertex), the caller's id of each, their grid, and the
   duplicates, each with the point at its place that stays, its canonical point.
   Holds: the order of the records depends on the coordinates alone; a vertex number is a rank on the curve.

   Points in one cell of the curve's grid form a run.  Short runs are put into lexicographic order; long ones get
   keys of their own from a grid over their own bounding box, and so on, so that clusters of any scale keep an order.
   A grid over a tight box separates its extremes: each nesting divides the extent by 2^bits, and doubles span 2^2098,
   which bounds the depth.

   The grid is fine because points on lines and surfaces lie in few of its cells.  Where points fill space, the first
   22 bits of their keys separate nearly all: all keys are sorted by these bits, and ties by the rest.  Where points
   lie in few cells, all keys are sorted by 44 bits.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbw__vertices {
    int dim, weighted;
    size_t count;                                    /* vertices, the ghost not counted */
    size_t point_count, duplicate_count, width;      /* width: of a record; 1 if there are none: see pbw__input */
    size_t room;                                     /* doubles in the block of the records */
    double *record;                                  /* (count+1)*width: coordinates, and weights if any */
    pbw_index *id;                                   /* count+1: the caller's number of each vertex */
    uint64_t *duplicate;                             /* duplicate_count: its number << 32 | the canonical point's */
    pbw_index *canonical;                            /* point_count; see pbw__make_canonical */
    pbw__grid grid;                                  /* of the records */
} pbw__vertices;

/* Returns whether x comes before y among equal keys: lexicographically, by larger weight, by lower index. */
PBW__DEVICE static int pbw__comes_before(const double *x, size_t i, const double *y, size_t j, int dim)
{
    int k;
    for (k = 0; k < dim; k++) {
        if (x[k] != y[k]) {
            return x[k] < y[k];
        }
    }
    return x[dim] != y[dim] ? x[dim] > y[dim] : i < j;
}

PBW__INLINE int pbw__same_place(const double *x, const double *y, int dim)
{
    return x[0] == y[0] && x[1] == y[1] && (dim == 2 || x[2] == y[2]);
}

/* A range of the keys, sorted by the bits from `low` up, not yet by those between the index and `low`. */
typedef struct pbw__part {
    size_t from, to;
    int low, settled;                                /* settled: all points lie at one place */
    size_t unique;                                   /* vertices in it */
} pbw__part;

typedef struct pbw__ordering {
    pbw__context *context;
    const pbw__input *input;
    pbw__vertices *vertices;
    uint64_t *keys;                                  /* key << index_bits | index */
    pbw__part *parts, part;                          /* these three: arrays if there are several tasks */
    pbw__grid_share *shares, share;                  /* per part: of its records */
    pbw__box *boxes, box;                            /* per task */
    uint32_t *start;                                 /* see pbw__sorting; NULL with one task */
    int tasks, index_bits, bits, not_finite;
    pbw__curve curve;                                /* the last member: large, and not always needed */
} pbw__ordering;

/* Keys of the points keys[from..from+count), or of all points, from a grid over their own box. */
typedef struct pbw__keying {
    pbw__ordering *ordering;
    size_t from, count;
    int all, tasks;
    pbw__box *boxes, box;                            /* per task; of all tasks */
} pbw__keying;

#define PBW__AHEAD 128                               /* distance of prefetches, in points */

/* Returns the i-th point of this range and prefetches a later one (never past `to`: another task writes there). */
PBW__INLINE size_t pbw__keying_index(const pbw__keying *keying, const pbw__input *input, size_t i, size_t to)
{
    const pbw__ordering *ordering = keying->ordering;
    const uint64_t *keys = ordering->keys + keying->from, mask = ((uint64_t)1 << ordering->index_bits) - 1;
    const size_t soon = i + PBW__AHEAD < to ? i + PBW__AHEAD : i;
    pbw__fetch_soon(input, keying->all ? soon : (size_t)(keys[soon] & mask));
    return keying->all ? i : (size_t)(keys[i] & mask);
}

PBW__INLINE void pbw__keying_box_share(const pbw__keying *keying, int task, int dim)
{
    const pbw__keying here = *keying;                /* a copy, as the stores below might alias it */
    const pbw__input input = *here.ordering->input;
    size_t i = pbw__share(here.count, task, here.tasks), end;
    const size_t to = pbw__share(here.count, task + 1, here.tasks);
    double zero = 0.0;
    pbw__box box;
    pbw__box_reset(&box, here.ordering->bits);
    for (; i < to; i = end) {
        for (end = to - i < PBW__TICK ? to : i + PBW__TICK; i < end; i++) {
            double x[4], none = 0.0;
            int k;
            pbw__fetch_of(&input, pbw__keying_index(&here, &input, i, to), x, dim);
            for (k = 0; k <= dim; k++) {
                none += x[k] - x[k];                 /* NaN if not finite */
            }
            zero += none;
            pbw__box_add(&box, x, dim);
        }
        if (pbw__report(here.ordering->context, 0.1 * (double)i / (double)here.count)) {
            break;
        }
    }
    if (zero != 0.0) {
        PBW__STORE(&here.ordering->not_finite, 1);
    }
    here.boxes[task] = box;
}

static void pbw__keying_box(void *arg, int task)
{
    const pbw__keying *keying = (const pbw__keying *)arg;
    PBW__BY_DIM(keying->ordering->input->dim, pbw__keying_box_share, keying, task);
}

/* Stores the keys of points i..to-1. */
PBW__INLINE void pbw__keying_share(const pbw__keying *keying, size_t i, size_t to, int levels, int dim)
{
    const pbw__ordering *ordering = keying->ordering;
    const pbw__box box = keying->box;
    const int index_bits = ordering->index_bits;
    uint64_t *keys = ordering->keys + keying->from;
    for (; i < to; i++) {
        double x[4];
        size_t index = pbw__keying_index(keying, ordering->input, i, to);
        if ((i & (PBW__TICK - 1)) == PBW__TICK - 1
            && pbw__report(ordering->context, 0.1 + 0.2 * (double)i / (double)keying->count)) {
            return;
        }
        pbw__fetch_of(ordering->input, index, x, dim);
        keys[i] = pbw__hilbert_key(ordering->curve.step, &box, x, dim, levels) << index_bits | (uint64_t)index;
    }
}

#ifdef PBW__AVX2
PBW__SIMD_INLINE const double *pbw__double_at(const pbw__input *input, size_t i)
{
    return (const double *)(const void *)(input->points + i * input->stride);
}

/* Stores the keys of points i..to-1, of all, given as doubles, by eights: the last eight may overlap those before.
   Returns the first point without a key: i, of fewer than eight. */
PBW__SIMD static size_t pbw__keying_plane(const pbw__keying *keying, size_t i, size_t to)
{
    const pbw__ordering *ordering = keying->ordering;
    const pbw__input input = *ordering->input;
    const pbw__box box = keying->box;
    const uint32_t all = ((uint32_t)1 << box.bits) - 1;
    const __m128i shift = _mm_cvtsi32_si128(ordering->index_bits);
    uint64_t *keys = ordering->keys;
    const size_t first = i;
    for (; i < to && to - first >= 8; i += 8) {
        __m256i index;
        pbw__d4 x0, y0, x1, y1;
        pbw__u8 x, y;
        __m256i low, high, key[2];
        size_t k;
        i = to - i >= 8 ? i : to - 8;
        if ((i & (PBW__TICK - 1)) < 8
            && pbw__report(ordering->context, 0.1 + 0.2 * (double)i / (double)keying->count)) {
            return to;
        }
        for (k = i + PBW__AHEAD; k < i + PBW__AHEAD + 8 && k < to; k += 2) {
            pbw__fetch_soon(&input, k);
        }
        index = _mm256_add_epi64(_mm256_set1_epi64x((int64_t)i), _mm256_setr_epi64x(0, 1, 2, 3));
        pbw__columns(pbw__double_at(&input, i), pbw__double_at(&input, i + 1), pbw__double_at(&input, i + 2),
                     pbw__double_at(&input, i + 3), &x0, &y0);
        pbw__columns(pbw__double_at(&input, i + 4), pbw__double_at(&input, i + 5), pbw__double_at(&input, i + 6),
                     pbw__double_at(&input, i + 7), &x1, &y1);
        x = pbw__cells8(&box, 0, x0, x1);
        y = pbw__cells8(&box, 1, y0, y1);
        high = (__m256i)pbw__digits8(x, y, all);
        low = (__m256i)(x ^ y);
        key[0] = pbw__interleave4(_mm256_castsi256_si128(high), _mm256_castsi256_si128(low));
        key[1] = pbw__interleave4(_mm256_extracti128_si256(high, 1), _mm256_extracti128_si256(low, 1));
        key[0] = _mm256_or_si256(_mm256_sll_epi64(key[0], shift), index);
        key[1] = _mm256_or_si256(_mm256_sll_epi64(key[1], shift), _mm256_add_epi64(index, _mm256_set1_epi64x(4)));
        _mm256_storeu_si256((__m256i *)(void *)(keys + i), key[0]);
        _mm256_storeu_si256((__m256i *)(void *)(keys + i + 4), key[1]);
    }
    return i;
}
#endif

static void pbw__keying_keys(void *arg, int task)
{
    const pbw__keying *keying = (const pbw__keying *)arg;
    pbw__ordering *ordering = keying->ordering;
    size_t from = pbw__share(keying->count, task, keying->tasks);
    size_t to = pbw__share(keying->count, task + 1, keying->tasks);
#ifdef PBW__AVX2
    if (ordering->input->dim == 2 && keying->all && !ordering->input->is_float && pbw__simd_works()) {
        from = pbw__keying_plane(keying, from, to);
    }
#endif
    if (from < to && ordering->curve.levels == 0) {          /* never with several tasks */
        pbw__curve_create(&ordering->curve, ordering->input->count, ordering->input->dim);
    }
    if (ordering->curve.levels == 1) {
        PBW__BY_DIM(ordering->input->dim, pbw__keying_share, keying, from, to, 1);
    } else if (ordering->input->dim == 3) {
        pbw__keying_share(keying, from, to, PBW__LEVELS3, 3);
    } else {
        pbw__keying_share(keying, from, to, PBW__LEVELS2, 2);
    }
}

/* Gives the points of a part keys of their own, unless they lie at one place.  Returns 0 if cancelled, or if a number
   is not finite.  boxes: one a task. */
static int pbw__order_keys(pbw__ordering *ordering, pbw__part *part, int all, pbw__box *boxes, int tasks)
{
    pbw__keying keying = { ordering, part->from, part->to - part->from, all, tasks, boxes, boxes[0] };
    int task, dim = ordering->input->dim;
    pbw__for(ordering->context, tasks, pbw__keying_box, &keying);
    if (PBW__LOAD(&ordering->context->cancelled) || PBW__LOAD(&ordering->not_finite)) {
        return 0;
    }
    keying.box = boxes[0];
    for (task = 1; task < tasks; task++) {
        pbw__box_add(&keying.box, boxes[task].low, dim);
        pbw__box_add(&keying.box, boxes[task].high, dim);
    }
    pbw__box_close(&keying.box, dim);
    part->settled = keying.box.extent == 0.0;
    if (part->settled && !all) {
        return 1;
    }
    keying.box.extent = part->settled ? 1.0 : keying.box.extent;
    pbw__for(ordering->context, tasks, pbw__keying_keys, &keying);
    part->low = ordering->index_bits + ordering->bits * dim;
    return !PBW__LOAD(&ordering->context->cancelled);
}

/* Sorts the keys of a part by their next bits, those from `low` on.  Returns 0 if cancelled.  start: see
   pbw__sorting, or NULL: on this thread alone.  The records of the part, which are written later, serve as room. */
static int pbw__order_sort(pbw__ordering *ordering, pbw__part *part, int low, uint32_t *start, int tasks)
{
    const size_t step = ordering->vertices->width;
    uint64_t *keys = ordering->keys + part->from, *sorted;
    pbw__sorting sorting = { ordering->context, keys, NULL, start, part->to - part->from, tasks, 0, 0 };
    sorting.b = (uint64_t *)(void *)(ordering->vertices->record + (part->from + 1) * step);
    sorted = start == NULL ? pbw__sort_keys(&sorting, low, part->low - low)
                           : pbw__sort_by(&sorting, low, part->low - low);
    if (sorted != NULL && sorted != keys) {
        memcpy(keys, sorted, sorting.count * sizeof(keys[0]));
    }
    part->low = low;
    return sorted != NULL;
}

#define PBW__SHORT_RUN 12
#define PBW__RUN_DEPTH 220                           /* > 1 + 2098 / 10, see the banner; 10 bits are the fewest */

/* Puts a run of at most PBW__SHORT_RUN equal keys into order. */
static void pbw__order_short_run(const pbw__ordering *ordering, uint64_t *keys, size_t count)
{
    const uint64_t mask = ((uint64_t)1 << ordering->index_bits) - 1;
    const int dim = ordering->input->dim;
    double x[PBW__SHORT_RUN][4], y[4];
    size_t i, hole;
    for (i = 0; i < count; i++) {                    /* first, so that the cache misses overlap */
        pbw__fetch(ordering->input, (size_t)(keys[i] & mask), x[i]);
    }
    for (i = 1; i < count; i++) {
        uint64_t moving = keys[i];
        memcpy(y, x[i], sizeof(y));
        for (hole = i; hole > 0 && pbw__comes_before(y, (size_t)(moving & mask), x[hole - 1],
                                                     (size_t)(keys[hole - 1] & mask), dim); hole--) {
            keys[hole] = keys[hole - 1];
            memcpy(x[hole], x[hole - 1], sizeof(y));
        }
        keys[hole] = moving;
        memcpy(x[hole], y, sizeof(y));
    }
}

/* Moves the point that stays, of points at one place, to the front. */
static void pbw__order_one_place(const pbw__ordering *ordering, uint64_t *keys, size_t count)
{
    const uint64_t mask = ((uint64_t)1 << ordering->index_bits) - 1;
    double x[4], best[4];
    size_t i;
    pbw__fetch(ordering->input, (size_t)(keys[0] & mask), best);
    for (i = 1; i < count; i++) {
        pbw__fetch(ordering->input, (size_t)(keys[i] & mask), x);
        if (pbw__comes_before(x, (size_t)(keys[i] & mask), best, (size_t)(keys[0] & mask), ordering->input->dim)) {
            uint64_t swap = keys[0];
            keys[0] = keys[i];
            keys[i] = swap;
            memcpy(best, x, sizeof(best));
        }
    }
}

/* Sorts the ties of a part by the remaining bits.  Returns 0 if cancelled.  A tie in order needs no sort. */
static int pbw__order_rest(pbw__ordering *ordering, const pbw__part *part)
{
    const uint64_t *keys = ordering->keys;
    pbw__part run;
    size_t i = part->from + 1, end;
    for (; i < part->to && part->low > ordering->index_bits; i = end) {
        for (end = part->to - i < PBW__TICK ? part->to : i + PBW__TICK; i < end; i++) {
            if (PBW__UNLIKELY(keys[i] < keys[i - 1])) {
                const uint64_t value = keys[i] >> part->low;
                run.low = part->low;
                for (run.from = i - 1; run.from > part->from && keys[run.from - 1] >> run.low == value; run.from--) {
                }
                for (run.to = i + 1; run.to < part->to && keys[run.to] >> run.low == value; run.to++) {
                }
                if (!pbw__order_sort(ordering, &run, ordering->index_bits, NULL, 1)) {
                    return 0;
                }
                i = run.to - 1;
                end = i < end ? end : run.to;
            }
        }
        if (pbw__report(ordering->context, 0.5)) {
            return 0;
        }
    }
    return 1;
}

/* Writes the points from..to-1 of a part, in the order of its keys, behind record r.  Duplicates are neighbours; they
   are listed where the first keys of the part were.  Prefetches points PBW__AHEAD.  Returns the last record. */
PBW__INLINE size_t pbw__order_place(const pbw__ordering *ordering, const pbw__part *part, size_t from, size_t to,
                                    size_t r, int dim)
{
    uint64_t *keys = ordering->keys, mask = ((uint64_t)1 << ordering->index_bits) - 1;
    const pbw__input input = *ordering->input;
    const size_t width = ordering->vertices->width, end = part->to;
    double *record = ordering->vertices->record + (r + 1) * width;
    const double *last = r > part->from ? record - width : ordering->vertices->record;       /* at first the ghost */
    pbw_index *id = ordering->vertices->id;
    for (; from < to && input.bare; from++) {
        id[++r] = (pbw_index)(keys[from] & mask);
    }
    for (; from < to; from++) {
        const size_t index = (size_t)(keys[from] & mask);
        pbw__fetch_soon(&input, (size_t)(keys[from + PBW__AHEAD < end ? from + PBW__AHEAD : from] & mask));
        record[width - 1] = 0.0;                     /* a weight that the points lack */
        pbw__fetch_place(&input, index, record, dim);
        if (PBW__UNLIKELY(pbw__same_place(record, last, dim))) {
            keys[part->from + from - r] = (uint64_t)index << 32 | id[r];
        } else {
            id[++r] = (pbw_index)index;
            last = record;
            record += width;
        }
    }
    return r;
}

/* Puts a run into order, points at one place next to each other, the one that stays first.  Returns 1; or -1 if the
   run got keys of its own, now in order, which may have runs in turn; or 0 if cancelled. */
static int pbw__order_run(pbw__ordering *ordering, pbw__part *run)
{
    const size_t count = run->to - run->from;
    uint64_t *keys = ordering->keys + run->from;
    pbw__box box;
    if (count <= PBW__SHORT_RUN) {
        pbw__order_short_run(ordering, keys, count);
        return 1;
    }
    if (!run->settled && !pbw__order_keys(ordering, run, 0, &box, 1)) {
        return 0;
    }
    if (!run->settled) {
        return pbw__order_sort(ordering, run, ordering->index_bits, NULL, 1) ? -1 : 0;
    }
    pbw__order_one_place(ordering, keys, count);
    return 1;
}

/* Puts the runs of a part into order and its points into the records, as if no other part had duplicates.  Works in
   steps of PBW__AHEAD points: orders their runs, then writes them, which prefetches the points of the next step. */
static void pbw__order_part(void *arg, int task)
{
    pbw__ordering *ordering = (pbw__ordering *)arg;
    pbw__part *part = ordering->parts + task, run;
    const pbw__input *input = ordering->input;
    const size_t width = ordering->vertices->width;
    const int bits = ordering->index_bits, dim = input->dim;
    const uint64_t *keys = ordering->keys;
    size_t end_of[PBW__RUN_DEPTH], r = part->from, i = part->from;
    pbw__grid_share share;
    int depth = 0;
    end_of[0] = part->to;
    pbw__grid_share_reset(&share);
    if (!pbw__order_rest(ordering, part)) {
        return;
    }
    while (i < part->to) {
        const size_t from = i, old = r, soon = part->to - i > PBW__AHEAD ? i + PBW__AHEAD : part->to;
        while (i < soon) {
            const size_t limit = end_of[depth], stop = soon < limit ? soon : limit - 1;
            int done = 1;
            while (i < stop && (keys[i] ^ keys[i + 1]) >> bits != 0) {
                i++;
            }
            if (i == soon) {
                break;
            }
            run.from = i++;
            while (i < limit && (keys[i] ^ keys[run.from]) >> bits == 0) {
                i++;
            }
            if (i - run.from > 1) {
                run.to = i;
                run.settled = part->settled;
                done = pbw__order_run(ordering, &run);
            }
            if (done == 0) {
                return;
            }
            if (done < 0) {                          /* look at the same place again, for runs in the run */
                end_of[++depth] = i;
                i = run.from;
            }
            while (depth > 0 && i == end_of[depth]) {
                depth--;
            }
        }
        r = PBW__BY_DIM(dim, pbw__order_place, ordering, part, from, i, r);
        if (!input->bare) {
            pbw__grid_add(&share, ordering->vertices->record + (old + 1) * width, r - old, dim, (int)width);
        }
        if (pbw__report(ordering->context, 0.5 + 0.5 * (double)i / (double)input->count)) {
            return;
        }
    }
    part->unique = r - part->from;
    ordering->shares[task] = share;
}

/* Returns the first of keys[from..to) whose bits from `low` on are not below `value`: a binary search. */
static size_t pbw__order_find(const uint64_t *keys, size_t from, size_t to, int low, uint64_t value)
{
    while (from < to) {
        size_t middle = from + (to - from) / 2;
        if (keys[middle] >> low < value) {
            from = middle + 1;
        } else {
            to = middle;
        }
    }
    return from;
}

/* Cuts the only part, all keys, into parts of one to two shares, but never a run.  Runs longer than 16 shares get
   keys of their own by all threads, and are cut in turn.  Returns the number of parts, at most PBW__CUTS * tasks; 0
   if cancelled. */
#define PBW__CUTS 16
static int pbw__order_cut(pbw__ordering *ordering)
{
    const int tasks = ordering->tasks;
    const size_t share = (ordering->input->count - 1) / ((size_t)tasks * 4) + 1;
    int parts = 1, p;
    for (p = 0; p < parts && tasks > 1; p++) {
        pbw__part part = ordering->parts[p], *next = ordering->parts + p + 1;
        const uint64_t *keys = ordering->keys;
        size_t at = part.from + share;
        uint64_t value;
        if (part.settled || part.to - part.from <= 2 * share || parts + 2 > PBW__CUTS * tasks) {
            continue;
        }
        memmove(next + 2, next, (size_t)(parts - p - 1) * sizeof(*next));
        parts += 2;
        next[0] = next[1] = part;
        value = keys[at] >> part.low;
        next[0].from = next[-1].to = pbw__order_find(keys, part.from, at, part.low, value);
        next[0].to = next[1].from = pbw__order_find(keys, at, part.to, part.low, value + 1);
        if (next->to - next->from > 16 * share) {
            const int all = pbw__tasks(ordering->context, next->to - next->from, 16384);
            if ((part.low == ordering->index_bits && !pbw__order_keys(ordering, next, 0, ordering->boxes, all))
                || (!next->settled && !pbw__order_sort(ordering, next, ordering->index_bits, ordering->start, all))) {
                return 0;
            }
        } else {
            p++;                                     /* a run: there is nothing to cut it at */
        }
    }
    return parts;
}

/* Returns whether the points lie in few cells of the grid: on lines, surfaces or in clusters.  Samples the 11 bits
   below `high` of 4096 keys. */
static int pbw__order_is_thin(const pbw__ordering *ordering, int high)
{
    const size_t step = ordering->input->count / 4096;
    unsigned char seen[2048 / 8];
    unsigned cells = 0, i;
    memset(seen, 0, sizeof(seen));
    for (i = 0; i < 4096; i++) {
        const unsigned cell = (unsigned)(ordering->keys[i * step] >> (high - 11)) & 2047;
        cells += ((unsigned)seen[cell >> 3] >> (cell & 7) & 1u) ^ 1u;
        seen[cell >> 3] |= (unsigned char)(1u << (cell & 7));
    }
    return cells < 2048 / 3;
}

static void pbw__vertices_free(pbw__context *context, pbw__vertices *vertices)
{
    size_t records = vertices->point_count + 1;
    pbw__release(&context->memory, vertices->record, vertices->room, sizeof(double));
    pbw__release(&context->memory, vertices->id, records, sizeof(pbw_index));
    pbw__release(&context->memory, vertices->duplicate, vertices->duplicate_count, sizeof(uint64_t));
    pbw__release(&context->memory, vertices->canonical, vertices->point_count, sizeof(pbw_index));
    vertices->record = NULL;
    vertices->id = NULL;
    vertices->duplicate = NULL;
    vertices->canonical = NULL;
}

/* Allocates the arrays of an ordering and its vertices.  Returns 0 if memory is short. */
static int pbw__order_begin(pbw__ordering *ordering)
{
    pbw__context *context = ordering->context;
    pbw_memory *memory = &context->memory;
    pbw__vertices *vertices = ordering->vertices;
    const size_t count = ordering->input->count, tasks = (size_t)ordering->tasks, step = vertices->width;
    pbw__block block[2];
    ordering->boxes = &ordering->box;
    ordering->parts = &ordering->part;
    ordering->shares = &ordering->share;
    if (tasks > 1) {
        ordering->boxes = (pbw__box *)pbw__allocate(memory, tasks, sizeof(pbw__box));
        ordering->start = (uint32_t *)pbw__allocate(memory, (tasks + 1) * PBW__DIGITS, sizeof(uint32_t));
        ordering->parts = (pbw__part *)pbw__allocate(memory, PBW__CUTS * tasks, sizeof(pbw__part));
        ordering->shares = (pbw__grid_share *)pbw__allocate(memory, PBW__CUTS * tasks, sizeof(pbw__grid_share));
        pbw__curve_create(&ordering->curve, count, vertices->dim);
    }
    vertices->id = (pbw_index *)pbw__allocate(memory, count + 1, sizeof(pbw_index));
    vertices->room = (count + 1) * (step + 1);
    vertices->record = (double *)pbw__allocate(memory, vertices->room, sizeof(double));
    if (vertices->record != NULL) {
        ordering->keys = (uint64_t *)(void *)(vertices->record + (count + 1) * step);
    }
    block[0] = pbw__block_of(vertices->id, 0, (count + 1) * sizeof(pbw_index));
    block[1] = pbw__block_of(vertices->record, 0, vertices->room * sizeof(double));
    pbw__populate(context, block, 2);
    return ordering->boxes != NULL && (ordering->start != NULL || tasks == 1) && ordering->parts != NULL
        && ordering->shares != NULL && vertices->id != NULL && vertices->record != NULL;
}

/* Frees what only the ordering needs; the keys lie behind the records.  In space the block keeps four doubles a point
   for the output: where it had to grow, it would move, which splits huge pages.  Not if memory is to be saved
   (PBW_BORROW), or if only the order is wanted.  Returns 0 if memory is short. */
static int pbw__order_end(pbw__ordering *ordering)
{
    pbw_memory *memory = &ordering->context->memory;
    pbw__vertices *vertices = ordering->vertices;
    const size_t tasks = (size_t)ordering->tasks;
    const int output = vertices->dim == 3 && !ordering->input->bare && !ordering->input->borrow;
    const size_t room = (vertices->point_count + 1) * (output ? 4 : vertices->width);
    if (tasks > 1) {
        pbw__release(memory, ordering->boxes, tasks, sizeof(pbw__box));
        pbw__release(memory, ordering->start, (tasks + 1) * PBW__DIGITS, sizeof(uint32_t));
        pbw__release(memory, ordering->parts, PBW__CUTS * tasks, sizeof(pbw__part));
        pbw__release(memory, ordering->shares, PBW__CUTS * tasks, sizeof(pbw__grid_share));
    }
    return vertices->record == NULL || room == vertices->room
        || pbw_memory_fit(memory, &vertices->record, &vertices->room, room, sizeof(double));
}

/* Sorts all keys and cuts them into parts.  Returns the number of parts, 0 if cancelled or a number is not finite. */
static int pbw__order_parts(pbw__ordering *ordering)
{
    const size_t count = ordering->input->count;
    pbw__part *all = ordering->parts;
    int low;
    all->from = 0;
    all->to = count;
    if (!pbw__order_keys(ordering, all, 1, ordering->boxes, ordering->tasks)) {
        return 0;
    }
    /* By one digit of pbw__sort_by or two: at most 4 of 16 million uniform points are equal there; or by four. */
    low = all->low - (count < 1024 ? (ordering->index_bits < 9 ? ordering->index_bits : 9) : count < 8192 ? 11
                      : pbw__order_is_thin(ordering, all->low) ? 44 : 22);
    low = low > ordering->index_bits ? low : ordering->index_bits;
    return pbw__order_sort(ordering, all, low, ordering->start, ordering->tasks) ? pbw__order_cut(ordering) : 0;
}

/* Closes the gaps that duplicates have left between the vertices of the parts, and lists the duplicates of all.
   Returns 0 if memory is short. */
static int pbw__order_close(const pbw__ordering *ordering, int parts)
{
    pbw__vertices *vertices = ordering->vertices;
    const size_t step = vertices->width;
    size_t listed = 0;
    int p;
    for (p = 0; p < parts; p++) {
        const size_t from = ordering->parts[p].from, unique = ordering->parts[p].unique;
        if (from != vertices->count && unique > 0) {
            memmove(vertices->record + (vertices->count + 1) * step, vertices->record + (from + 1) * step,
                    unique * step * sizeof(double));
            memmove(vertices->id + vertices->count + 1, vertices->id + from + 1, unique * sizeof(pbw_index));
        }
        vertices->count += unique;
    }
    vertices->duplicate_count = vertices->point_count - vertices->count;
    if (!ordering->input->bare) {
        pbw__grid_close(&vertices->grid, ordering->shares, parts, vertices->dim);
    }
    if (vertices->duplicate_count > 0) {
        vertices->duplicate = (uint64_t *)pbw__allocate_large(ordering->context, vertices->duplicate_count,
                                                              sizeof(uint64_t));
    }
    for (p = 0; p < parts && vertices->duplicate != NULL; p++) {
        const pbw__part *part = ordering->parts + p;
        const size_t duplicates = part->to - part->from - part->unique;
        memcpy(vertices->duplicate + listed, ordering->keys + part->from, duplicates * sizeof(uint64_t));
        listed += duplicates;
    }
    return vertices->duplicate != NULL || vertices->duplicate_count == 0;
}

static pbw_status pbw__fill_canonical(void *arg, size_t from, size_t to)
{
    pbw_index *canonical = ((const pbw__vertices *)arg)->canonical;
    for (; from < to; from++) {
        canonical[from] = (pbw_index)from;
    }
    return PBW_OK;
}

static pbw_status pbw__place_duplicates(void *arg, size_t from, size_t to)
{
    const pbw__vertices *vertices = (const pbw__vertices *)arg;
    for (; from < to; from++) {
        vertices->canonical[vertices->duplicate[from] >> 32] = (pbw_index)vertices->duplicate[from];
    }
    return PBW_OK;
}

/* Makes `canonical` in a block of its size, or in a new one if that is NULL. */
static pbw_status pbw__make_canonical(pbw__context *context, pbw__vertices *vertices, pbw_index *block)
{
    pbw_status status;
    vertices->canonical = block != NULL ? block
        : (pbw_index *)pbw__allocate_large(context, vertices->point_count, sizeof(pbw_index));
    status = vertices->canonical == NULL ? PBW_ERROR_MEMORY
           : pbw__for_range(context, vertices->point_count, 8192, 0.0, pbw__fill_canonical, vertices);
    return status != PBW_OK ? status
         : pbw__for_range(context, vertices->duplicate_count, PBW__TICK, 0.0, pbw__place_duplicates, vertices);
}

/* Orders the points, at least one.  Returns PBW_OK, or an error with all memory released. */
static pbw_status pbw__order(pbw__context *context, const pbw__input *input, pbw__vertices *vertices)
{
    const int dim = input->dim;
    pbw__ordering ordering;
    pbw_status status = PBW_ERROR_MEMORY;
    int parts;
    memset(&ordering, 0, offsetof(pbw__ordering, curve));
    ordering.curve.levels = 0;
    ordering.context = context;
    ordering.input = input;
    ordering.vertices = vertices;
    ordering.tasks = pbw__tasks(context, input->count, 4096);
    ordering.index_bits = pbw__index_bits(input->count);
    ordering.bits = pbw__grid_bits(ordering.index_bits, dim);
    memset(vertices, 0, sizeof(*vertices));
    vertices->dim = dim;
    vertices->weighted = input->weights != NULL;
    vertices->point_count = input->count;
    vertices->width = input->bare ? 1 : (size_t)dim + (input->weights != NULL || input->padded);
    if (pbw__order_begin(&ordering)) {
        parts = pbw__order_parts(&ordering);
        memset(vertices->record, 0, vertices->width * sizeof(double));
        vertices->record[0] = HUGE_VAL;              /* vectors know the ghost by it */
        vertices->id[0] = PBW_NONE;
        pbw__for(context, parts, pbw__order_part, &ordering);
        status = ordering.not_finite ? PBW_ERROR_NOT_FINITE : PBW__LOAD(&context->cancelled) ? PBW_CANCELLED : PBW_OK;
        if (status == PBW_OK && !pbw__order_close(&ordering, parts)) {
            status = PBW_ERROR_MEMORY;
        }
    }
    status = !pbw__order_end(&ordering) && status == PBW_OK ? PBW_ERROR_MEMORY : status;
    if (status != PBW_OK) {
        pbw__vertices_free(context, vertices);
    }
    return status;
}
/* ------------------------------------------------------------------------------------------------------
   >>mesh         The triangulation while it is built, and one thread's view of it.
   Simplex t has the vertices corner[4*t + i] and, across from each, link[4*t + i]: 4*neighbour + the number of the
   neighbour's corner across the shared facet.  So corner[link] is the far vertex, link[link] the link back, each one
   load.  In 3D that is 32 bytes a simplex; in 2D the fourth entries are not used.

   Vertex 0 is the ghost vertex at infinity: each facet of the hull carries a ghost simplex, so that every facet has
   two sides and the hull needs no cases of its own.

   Holds, between insertions:
     - every link's link back is itself; the two simplices have the facet's vertices in common;
     - finite simplices are positively oriented, ghost simplices are as if the ghost vertex lay far outside their
     facet;
     - the ghost vertex is in the last corner;
     - no vertex inserted so far is in conflict with a simplex (>>predicates has the rule for ties);
     - all marks are 0; a free slot that was used has PBW_NONE in corner 0 and the next one in corner 1.
   ------------------------------------------------------------------------------------------------------ */
#ifdef PBW_WIDE
typedef uint64_t pbw__link;
#define PBW__SIMPLEX_LIMIT ((size_t)PBW_NONE - 1)
#else
typedef uint32_t pbw__link;
#define PBW__SIMPLEX_LIMIT ((size_t)1 << 30)
#endif
#ifdef PBW__TEST_SIMPLEX_LIMIT                       /* a limit that small inputs reach */
#undef PBW__SIMPLEX_LIMIT
#define PBW__SIMPLEX_LIMIT ((size_t)PBW__TEST_SIMPLEX_LIMIT)
#endif

#define PBW__GHOST 0u
#define PBW__MARK ((pbw_index)1 << 31)               /* of corners, in the plane: see >>cavity2 */
#define PBW__DEFERRED ((pbw_status)15)               /* not inserted: for the next round of >>parallel */
#define PBW__RING_OVERFLOW ((pbw_status)14)          /* not inserted: the cavity does not fit >>cavity2's ring */
#define PBW__FOREIGN (PBW_NONE - 1)                  /* returned by a walk that would leave our zones */

/* The simplices, shared by all threads. */
typedef struct pbw__store {
    pbw_index *corner;
    pbw__link *link;
    unsigned char *mark;                             /* 3D: 1 for a simplex of a cavity; pbw_live.h: in 2D, too */
    size_t corner_capacity, link_capacity, mark_capacity;
    size_t capacity;                                 /* in simplices, the least of all */
    int plain;                                       /* no marks: in the plane, without pbw_live.h, and for output */
    int lent;                                        /* the output only reads: 1 `link`, 2 `corner`, too */
    size_t count;                                    /* slots given to regions and threads */
    pbw_index *region;                               /* per region: its first slot that was never used */
    pbw_index *hint;                                 /* >>parallel: per zone, at its first region: where walks may
                                                        start, or PBW_NONE */
    size_t region_count, region_slots;               /* slots from region_slots on are the tail */
    size_t slots_each, ahead;                        /* of a region; how many more the first one has */
    int region_bits;                                 /* vertex >> region_bits is the number of its region */
} pbw__store;

/* >>slots: those that one thread may use. */
typedef struct pbw__slots {
    size_t region;                                   /* of the last vertex; (size_t)-1: none yet */
    size_t fresh, fresh_end;                         /* slots of this region that were never used */
    size_t tail, tail_end;                           /* slots of the tail that were never used */
    size_t free_count;
    pbw_index free_list, free_last;                  /* slots that became free, linked through corner 1 */
    int no_room;                                     /* the store has no more blocks */
} pbw__slots;

/* >>parallel: the zones that one task owns. */
#define PBW__CLAIMS 2048                             /* zones that a task owns, at most */
#define PBW__NOBODY 255                              /* the owner of a zone that any task may take */
typedef struct pbw__ownership {
    uint8_t *owner;                                  /* per zone: the task that owns it; NULL: all zones are ours */
    uint8_t me, share;                               /* this task; the share of the vertices that it works on */
    uint8_t blocker;                                 /* the owner of the last zone that we could not claim */
    int owner_bits;                                  /* vertex >> owner_bits is the number of its zone */
    int renewed;                                     /* simplices were made since zones were last given back */
    int claim_count;
    size_t missed;                                   /* insertions of the round that failed */
    pbw_index claim[PBW__CLAIMS];                    /* our zones; the last member, not cleared */
} pbw__ownership;

/* A simplex of the cavity: its corners, their local numbers, and the links across from them (3D). */
typedef struct pbw__carved {
    pbw_index v[4], local[4];
    pbw__link link[4];
#ifndef PBW_WIDE
    pbw_index pad[4];                                /* to a cache line */
#endif
} pbw__carved;

/* A facet of the new star, by the edge of the cavity's boundary that it has. */
typedef struct pbw__edge { pbw_index low, high; pbw__link link; } pbw__edge;

/* In 3D the vertices of a cavity get local numbers, in the order in which they are met, from a hash table: an entry
   is stamp << 40 | vertex << 8 | number, empty if its stamp is not this insertion's.  Larger cavities do without. */
#define PBW__TABLE 1024
#define PBW__LOCALS 256
#define PBW__STAMP ((uint64_t)1 << 40)
#define PBW__STAMPS (1u << 24)
#define PBW__FEW 64                                  /* most cavities have fewer vertices: a small table is enough */

/* The memory of one insertion. */
typedef struct pbw__scratch {
    pbw_index *cavity;                               /* simplices in conflict; then the slots of the star */
    pbw_index *parent;                               /* 3D: the facet that each was met through, as in `from` */
    pbw__carved *carved;                             /* 3D: the same simplices, for the refill */
    pbw__link *beyond;                               /* 2D: the boundary of the cavity: the link across each edge */
    pbw_index *from;                                 /* 3D: the facets there: 4 * index in the cavity + which one */
    pbw__link *stack;                                /* 2D: links that are still to be searched */
    size_t cavity_count, facet_count;
    size_t cavity_capacity, parent_capacity, carved_capacity, beyond_capacity, from_capacity, stack_capacity;
    uint64_t *table;                                 /* 3D: local numbers */
    uint32_t stamp, local_count;
    pbw__link *edge;                                 /* 3D: by pairs of local numbers, of few or of all */
    pbw__edge *wide;                                 /* 3D: a hash table by pairs of vertices, for large cavities */
    size_t edge_capacity, wide_capacity;
    pbw_index back[4 * 2 * PBW__FEW];                /* indices in `edge`; 64 vertices have at most 124 facets */
} pbw__scratch;

/* One thread's view of a triangulation. */
typedef struct pbw__kernel {
    char apart[128];                                 /* against false sharing */
    uint8_t asked;                                   /* >>parallel: another task needs one of our zones */
    char asked_apart[127];                           /* others write `asked`, and we read it after each vertex */
    pbw__context *context;
    pbw__store *store;
    const double *record;                            /* vertex records: coordinates; a weight if width is dim+1 */
    size_t width;
    const pbw__grid *grid;
    int dim, weighted;                               /* not weighted: every vertex stays one, none becomes hidden */
    double exact_height;                             /* below it the filters make no error, see >>predicates */
    pbw_index *corner;                               /* the store's arrays */
    pbw__link *link;
    unsigned char *mark;
    pbw_index last;                                  /* a simplex of the last star */
    pbw_index previous, vertex_count;                /* 2D: the last vertex; how many there are */
    /* Inserts a vertex, with the code for this dimension and processor; a hidden one changes nothing. */
    pbw_status (*insert)(struct pbw__kernel *kernel, pbw_index vertex);
    /* With a journal: before the simplices of a cavity are deleted; and before its star fills its slots. */
    pbw_status (*note_cavity)(struct pbw__kernel *kernel), (*note_slots)(struct pbw__kernel *kernel);
    pbw__slots slots;
    pbw__scratch scratch;
    void *journal;                                   /* NULL, or what undoes insertions, as in pbw_live.h */
    pbw_index *left;                                 /* vertices left for the next round */
    size_t left_count, left_capacity, done, reported;
    pbw_status status;
    pbw_statistics statistics;
    pbw__ownership own;                              /* the last member: large, and cleared in part */
    char apart_too[128];
} pbw__kernel;

/* Makes room for `needed` items in the array x, beside which its size x_capacity is. */
#define PBW__GROW(kernel, owner, x, needed) \
    pbw_memory_grow(&(kernel)->context->memory, &(owner)->x, &(owner)->x##_capacity, needed, 0, sizeof(*(owner)->x))

static void pbw__kernel_free(pbw__kernel *kernel)
{
    pbw_memory *memory = &kernel->context->memory;
    PBW__RELEASE(memory, &kernel->scratch, cavity);
    PBW__RELEASE(memory, &kernel->scratch, parent);
    PBW__RELEASE(memory, &kernel->scratch, carved);
    PBW__RELEASE(memory, &kernel->scratch, beyond);
    PBW__RELEASE(memory, &kernel->scratch, from);
    PBW__RELEASE(memory, &kernel->scratch, stack);
    pbw__release(memory, kernel->scratch.table, PBW__TABLE, sizeof(uint64_t));
    PBW__RELEASE(memory, &kernel->scratch, edge);
    PBW__RELEASE(memory, kernel, left);
    PBW__RELEASE(memory, &kernel->scratch, wide);
}

PBW__INLINE void pbw__kernel_attach(pbw__kernel *kernel)
{
    kernel->corner = kernel->store->corner;
    kernel->link = kernel->store->link;
    kernel->mark = kernel->store->mark;
}

/* Corners of facet i, from the second entry on, in the order that makes (p, a, b, c) positive for p inside. */
static const unsigned char pbw__facet_corners[4][4] = {
    { 0, 1, 2, 3 }, { 0, 2, 0, 3 }, { 0, 0, 1, 3 }, { 0, 0, 2, 1 }
};

PBW__INLINE const double *pbw__record_at(const pbw__kernel *kernel, pbw_index v)
{
    return kernel->record + kernel->width * v;
}

/* Copies a record, with a weight, which is zero without weights. */
PBW__INLINE void pbw__copy_record(const double *record, double *copy, int dim, int weighted)
{
    memcpy(copy, record, (size_t)dim * sizeof(double));
    copy[dim] = weighted ? record[dim] : 0.0;
}

PBW__INLINE void pbw__corners_of(const pbw__kernel *kernel, pbw_index t, const double **x)
{
    int i;
    for (i = 0; i <= kernel->dim; i++) {             /* pbw__in_conflict may ask for a simplex of the cavity */
        x[i] = pbw__record_at(kernel, kernel->corner[4 * (size_t)t + (size_t)i] & ~PBW__MARK);
    }
}

/* Returns whether p is in conflict with any simplex, ghosts included, exactly.  A ghost with the point in its facet's
   plane is in conflict exactly when the finite simplex behind the facet is. */
static PBW__NOINLINE int pbw__simplex_conflict(const pbw__kernel *kernel, pbw_index t, const double *p)
{
    const int dim = kernel->dim;
    const size_t last = 4 * (size_t)t + (size_t)dim;
    double copy[4][4];
    const double *x[4];
    int i;
    pbw__corners_of(kernel, t, x);
    if (kernel->corner[last] == PBW__GHOST) {
        const int side = pbw__side(dim, x, dim, p, kernel->grid);
        if (side != 0) {
            return side > 0;
        }
        pbw__corners_of(kernel, (pbw_index)(kernel->link[last] >> 2), x);
    }
    for (i = 0; i <= dim; i++) {
        pbw__copy_record(x[i], copy[i], dim, kernel->weighted);
        x[i] = copy[i];
    }
    return pbw__conflict(dim, x, p, kernel->grid);
}

/* pbw__simplex_conflict for a thread with a kernel of its own, where it counts. */
PBW__INLINE int pbw__in_conflict(pbw__kernel *kernel, pbw_index t, const double *p)
{
    kernel->statistics.exact_tests++;
    return pbw__simplex_conflict(kernel, t, p);
}

/* Ownership, defined in >>parallel.  They return whether this thread owns a zone or a vertex, may delete a simplex,
   may cross a facet. */
PBW__INLINE int pbw__owns_zone(pbw__kernel *kernel, size_t zone);
PBW__INLINE int pbw__owns(pbw__kernel *kernel, pbw_index v);
PBW__INLINE unsigned pbw__is_ours(const pbw__kernel *kernel, pbw_index v);
PBW__INLINE int pbw__may_delete(pbw__kernel *kernel, pbw_index t);
PBW__INLINE int pbw__may_cross(pbw__kernel *kernel, pbw_index t, unsigned facet);
#ifdef PBW__SIMD
PBW__INLINE unsigned pbw__lacking4(const pbw__kernel *kernel, pbw_index a, pbw_index b, pbw_index c, pbw_index d);
static PBW__NOINLINE int pbw__may_delete_all(pbw__kernel *kernel, const pbw__carved *carved, unsigned lacking,
                                             unsigned inside);
#endif
/* ------------------------------------------------------------------------------------------------------
   >>slots        Where simplices are stored.
   In: the number of vertices; then, for each insertion, the slots of its cavity and how many its star needs.
   Out: slots for the star.
   Holds: a slot is in a simplex, free in one thread's list, or was never used.

   Each span of ranks has a region of slots: a star takes the slots of its cavity, and what it needs more from the
   region of its vertex.  Ranks follow the Hilbert curve; so simplices close in space are close in memory, and the
   output finds them nearly in order.  Past the regions lies the tail, for regions that are full.
   ------------------------------------------------------------------------------------------------------ */
/* Resizes the store to `needed` simplices. */
static PBW__NOINLINE pbw_status pbw__store_reserve(pbw__context *context, pbw__store *store, size_t needed)
{
    pbw_memory *memory = &context->memory;
    const size_t old = store->capacity;
    pbw__block block[3];
    if (needed > PBW__SIMPLEX_LIMIT) {
        return PBW_ERROR_TOO_LARGE;
    }
    if (!PBW__RESIZE(memory, store, corner, 4 * needed)
        || !PBW__RESIZE(memory, store, link, 4 * needed)
        || (!store->plain && !PBW__RESIZE(memory, store, mark, needed))) {
        return PBW_ERROR_MEMORY;
    }
    block[0] = pbw__block_of(store->corner, 4 * old * sizeof(pbw_index), 4 * needed * sizeof(pbw_index));
    block[1] = pbw__block_of(store->link, 4 * old * sizeof(pbw__link), 4 * needed * sizeof(pbw__link));
    block[2] = pbw__block_of(store->mark, old, needed);
    pbw__populate(context, block, 3);
    if (!store->plain && needed > old) {
        pbw__set_bytes(context, store->mark + old, 0, needed - old);
    }
    store->capacity = needed;
    return PBW_OK;
}

/* Returns the next capacity.  A store with a long tail grows by an eighth.  One that was full before most vertices of
   a round were in grows by an eleventh: terrain, 7.45 tetrahedra a vertex, needs no more.  Any other: a sixteenth. */
PBW__INLINE size_t pbw__store_bigger(const pbw__store *store, int most_left)
{
    size_t tail = store->capacity - store->region_slots;
    size_t part = tail >= store->capacity / 8 ? 8 : most_left ? 11 : 16;
    size_t bigger = store->capacity + store->capacity / part + 1024;
    return bigger < PBW__SIMPLEX_LIMIT ? bigger : PBW__SIMPLEX_LIMIT;
}

/* Returns the slot after the last of a region. */
PBW__INLINE size_t pbw__region_end(const pbw__store *store, size_t region)
{
    size_t end = store->ahead + (region + 1) * store->slots_each;
    return end < store->region_slots && region + 1 < store->region_count ? end : store->region_slots;
}

/* There are at most 65536 regions, as each round of >>parallel visits all of them; with less than 128 ranks (2D: 512)
   too many would be full while others are not. */
static int pbw__region_bits(size_t vertices, int dim)
{
    int bits = dim == 3 ? 7 : 9;
    while (vertices >> bits >= 65536) {
        bits++;
    }
    return bits;
}

/* Regions and a tail.  A region has slots for 6 7/8 simplices a vertex in space: uniform points need 6.77, and the
   tail takes the surplus of one region in five.  In the plane each vertex makes two more triangles than it deletes,
   ghosts included, so a region needs two slots a vertex and two more for the first star.  The output moves each
   simplex to a position in the order of lowest ranks.  About n^(2/3) of the first n ranks share simplices with higher
   ranks, in slots of later regions.  In space the first region has spare slots for them, so that positions do not
   get ahead of the slots that are read. */
static pbw_status pbw__store_create(pbw__context *context, pbw__store *store, size_t vertices, int dim)
{
    pbw_memory *memory = &context->memory;
    size_t slots, tail = 64 + vertices / (dim == 3 ? 32 : 1024), side = 1, r;
    pbw_status status;
    store->region_bits = pbw__region_bits(vertices, dim);
    store->slots_each = ((size_t)1 << store->region_bits) / 16 * (dim == 3 ? 110 : 32) + (dim == 3 ? 0 : 2);
    while (side * side * side < vertices) {
        side++;
    }
    store->ahead = dim == 3 ? 4 * side * side : 0;
    slots = (size_t)((uint64_t)(vertices + 1) * store->slots_each >> store->region_bits) + store->ahead + 16;
    store->region_slots = slots < PBW__SIMPLEX_LIMIT ? slots : PBW__SIMPLEX_LIMIT;
    store->region_count = (vertices >> store->region_bits) + 1;
    store->region = (pbw_index *)pbw__allocate(memory, store->region_count, sizeof(pbw_index));
    store->hint = (pbw_index *)pbw__allocate(memory, store->region_count, sizeof(pbw_index));
    slots = store->region_slots + tail < PBW__SIMPLEX_LIMIT ? store->region_slots + tail : PBW__SIMPLEX_LIMIT;
    status = store->region != NULL && store->hint != NULL ? pbw__store_reserve(context, store, slots)
                                                          : PBW_ERROR_MEMORY;
    for (r = 0; r < store->region_count && status == PBW_OK; r++) {
        store->region[r] = (pbw_index)(r > 0 ? pbw__region_end(store, r - 1) : 0);
        store->hint[r] = PBW_NONE;
    }
    store->count = store->region_slots;
    return status;
}

/* Marks the slots that no simplex has used as free, in some regions. */
static pbw_status pbw__close_regions(void *arg, size_t from, size_t to)
{
    pbw__store *store = (pbw__store *)arg;
    size_t t, end;
    for (; from < to; from++) {
        for (t = store->region[from], end = pbw__region_end(store, from); t < end; t++) {
            store->corner[4 * t] = PBW_NONE;
        }
    }
    return PBW_OK;
}

static void pbw__store_free(pbw_memory *memory, pbw__store *store)
{
    pbw__release(memory, store->region, store->region_count, sizeof(pbw_index));
    pbw__release(memory, store->hint, store->region_count, sizeof(pbw_index));
    PBW__RELEASE(memory, store, corner);
    PBW__RELEASE(memory, store, link);
    PBW__RELEASE(memory, store, mark);
    memset(store, 0, sizeof(*store));
}

/* Clears the marks of an abandoned cavity. */
static PBW__NOINLINE pbw_status pbw__leave_cavity(pbw__kernel *kernel, size_t count)
{
    size_t i;
    for (i = 0; i < count && kernel->mark != NULL; i++) {
        kernel->mark[kernel->scratch.cavity[i]] = 0;
    }
    return PBW__DEFERRED;
}

/* Makes room for `needed` items in each of the lists of cavity and boundary. */
static PBW__NOINLINE int pbw__grow_lists(pbw__kernel *kernel, size_t needed)
{
    return (kernel->dim == 2 || needed <= PBW_NONE / 4)          /* a facet in 32 bits */
        && PBW__GROW(kernel, &kernel->scratch, cavity, needed)
        && (kernel->dim == 2
                ? PBW__GROW(kernel, &kernel->scratch, beyond, needed)
                  && PBW__GROW(kernel, &kernel->scratch, stack, needed)
                : PBW__GROW(kernel, &kernel->scratch, carved, needed)
                  && PBW__GROW(kernel, &kernel->scratch, parent, needed)
                  && PBW__GROW(kernel, &kernel->scratch, from, needed));
}

static void pbw__leave_region(pbw__kernel *kernel)
{
    if (kernel->slots.region != (size_t)-1) {
        kernel->store->region[kernel->slots.region] = (pbw_index)kernel->slots.fresh;
        kernel->slots.region = (size_t)-1;
    }
    kernel->slots.fresh = kernel->slots.fresh_end = 0;
}

/* Takes slots from the region of the next vertex from now on. */
static PBW__NOINLINE void pbw__enter_region(pbw__kernel *kernel, size_t region)
{
    pbw__leave_region(kernel);
    kernel->slots.region = region;
    kernel->slots.fresh = kernel->store->region[region];
    kernel->slots.fresh_end = pbw__region_end(kernel->store, region);
}

/* Puts a slot into the list of free ones. */
PBW__INLINE void pbw__free_slot(pbw__kernel *kernel, pbw_index t)
{
    kernel->corner[4 * (size_t)t] = PBW_NONE;
    kernel->corner[4 * (size_t)t + 1] = kernel->slots.free_list;
    kernel->slots.free_list = t;
    kernel->slots.free_last = kernel->slots.free_count == 0 ? t : kernel->slots.free_last;
    kernel->slots.free_count++;
}

/* Takes a block of the tail, of at least `needed` slots.  Only a thread that is alone can grow the tail. */
static PBW__NOINLINE pbw_status pbw__more_tail(pbw__kernel *kernel, size_t needed)
{
    pbw__store *store = kernel->store;
    const size_t most = needed > 256 ? needed : 256;
    size_t block, from, t;
    if (kernel->own.owner == NULL && store->capacity - store->count < needed) {
        const size_t bigger = pbw__store_bigger(store, 0), least = store->count + needed;
        const pbw_status status = pbw__store_reserve(kernel->context, store, bigger > least ? bigger : least);
        pbw__kernel_attach(kernel);
        if (status != PBW_OK) {
            return status;
        }
    }
    from = PBW__LOAD(&store->count);
    do {
        PBW__TEST_PAUSE();
        block = store->capacity - from < most ? store->capacity - from : most;
        if (block < needed) {
            kernel->slots.no_room = 1;               /* at the end of the round there will be more */
            return PBW__DEFERRED;
        }
    } while (!PBW__CAS(&store->count, &from, from + block));
    for (t = kernel->slots.tail; t < kernel->slots.tail_end; t++) {
        pbw__free_slot(kernel, (pbw_index)t);
    }
    kernel->slots.tail = from;
    kernel->slots.tail_end = from + block;
    for (t = from; t < from + block; t++) {
        kernel->corner[4 * t] = PBW_NONE;
    }
    return PBW_OK;
}

/* Returns a slot; the caller knows that there is one. */
static PBW__NOINLINE pbw_index pbw__take_slot(pbw__kernel *kernel)
{
    pbw__slots *slots = &kernel->slots;
    pbw_index t;
    if (slots->fresh < slots->fresh_end) {
        t = (pbw_index)slots->fresh++;
    } else if (slots->free_count > 0) {
        t = slots->free_list;
        slots->free_list = kernel->corner[4 * (size_t)t + 1];
        PBW__PREFETCH_TO_WRITE(kernel->corner + 4 * (size_t)(slots->free_count > 1 ? slots->free_list : t));
        slots->free_count--;
    } else {
        t = (pbw_index)slots->tail++;
    }
    return t;
}

/* Takes the slots of the star: those of the cavity first, still marked; surplus slots of the cavity become free. */
PBW__INLINE pbw_status pbw__take_slots(pbw__kernel *kernel)
{
    pbw__slots *slots = &kernel->slots;
    const size_t have = kernel->scratch.cavity_count, needed = kernel->scratch.facet_count;
    const size_t fresh = slots->fresh_end - slots->fresh, tail = slots->tail_end - slots->tail;
    const size_t room = have + fresh + slots->free_count + tail;
    pbw_index *cavity;
    size_t i;
    if (PBW__UNLIKELY(needed > room) || PBW__UNLIKELY(kernel->journal != NULL)) {
        pbw_status status = needed > room ? pbw__more_tail(kernel, needed - room) : PBW_OK;
        status = status == PBW_OK && kernel->journal != NULL ? kernel->note_cavity(kernel) : status;
        if (status != PBW_OK) {
            (void)pbw__leave_cavity(kernel, have);
            return status;
        }
    }
    if (PBW__UNLIKELY(needed + 8 > kernel->scratch.cavity_capacity) && !pbw__grow_lists(kernel, needed + 8)) {
        return PBW_ERROR_MEMORY;
    }
    cavity = kernel->scratch.cavity;
    if (PBW__LIKELY(needed >= have) && PBW__LIKELY(fresh >= needed - have)) {
        for (i = have; i < needed; i += 8) {         /* by eights: how many are needed is unpredictable */
            pbw_index next = (pbw_index)(slots->fresh + (i - have)), k;
            for (k = 0; k < 8; k++) {
                cavity[i + k] = next + k;
            }
        }
        slots->fresh += needed - have;
    } else {
        for (i = have; i < needed; i++) {
            cavity[i] = pbw__take_slot(kernel);
        }
    }
    for (i = needed; i < have; i++) {
        if (kernel->mark != NULL) {
            kernel->mark[cavity[i]] = 0;
        }
        pbw__free_slot(kernel, cavity[i]);
    }
    kernel->statistics.created += needed;
    kernel->last = cavity[needed - 1];
    return PBW__UNLIKELY(kernel->journal != NULL) ? kernel->note_slots(kernel) : PBW_OK;
}
/* ------------------------------------------------------------------------------------------------------
   >>walk         Point location.
   In: a point that is no vertex, a simplex to start from.  Out: a simplex in conflict with the point, or for weighted
   points that are hidden, none.

   A visibility walk (Devillers, Pion & Teillaud 2002, "Walking in a triangulation"): step through a facet that has
   the point strictly on its far side.
     1. It ends, because every step is taken on an exact sign, and in a Delaunay or regular triangulation the relation
        "in front of, seen from a fixed point" has no cycle (Edelsbrunner 1990, "An acyclicity theorem for cell
        complexes in d dimensions").
     2. Of several such facets any will do; the path is shorter through the one with the most negative volume; vectors
        in 2D have a rule of their own.  What overflows or vanishes there makes it longer at worst.
     3. The four orientations S_i also give the sphere test, sum(lift_i * S_i), so the walk stops at the first simplex
        that is certainly in conflict; its neighbourhood is the cavity's all the same.

   Errors: see >>predicates.  An orientation S is compared as S^2 with the square of its bound, h raised to 1e-55 if
   it is less; with vectors in 2D as it is.  Where something overflows the bound is infinite, or a comparison with it
   false.  On a small grid (>>cavity3) the bound of 2D is less than a unit^2: a side that it leaves open is zero.
   ------------------------------------------------------------------------------------------------------ */
PBW__INLINE double pbw__det3(const double *a, const double *b, const double *c)
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
         + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* The row of a vertex relative to p: coordinates and lift, zero for the ghost.  Returns its height. */
PBW__INLINE double pbw__row(const pbw__kernel *kernel, pbw_index v, const double *p, double *row, int dim)
{
    const double *record = pbw__record_at(kernel, v);
    double square, weight = kernel->weighted ? record[dim] - p[dim] : 0.0;
    if (v == PBW__GHOST) {
        row[0] = row[1] = row[2] = row[dim] = 0.0;
        return 0.0;
    }
    row[0] = record[0] - p[0];
    row[1] = record[1] - p[1];
    square = row[0] * row[0] + row[1] * row[1];
    if (dim == 3) {
        row[2] = record[2] - p[2];
        square = square + row[2] * row[2];
    }
    row[dim] = square - weight;
    return square + pbw__abs(weight);
}

#ifdef PBW__SIMD
/* Four rows by columns, a vertex in each lane; in the plane z is zero.  Lanes of the ghost are zero and masked.  hull
   is 0 if the caller knows that no vertex is the ghost. */
typedef struct pbw__rows4 { pbw__d4 x, y, z, lift, height, ghost; } pbw__rows4;
typedef struct pbw__point4 { pbw__d4 x, y, z, weight; const double *p; size_t width; int dim, weighted; } pbw__point4;

#define PBW__CORNER_A(x) PBW__PICK(x, 1, 2, 0, 0) /* pbw__facet_corners by columns */
#define PBW__CORNER_B(x) PBW__PICK(x, 2, 0, 1, 2)
#define PBW__CORNER_C(x) PBW__PICK(x, 3, 3, 3, 1)
#define PBW__EDGE_START(x) PBW__PICK(x, 1, 2, 0, 1) /* in the plane: the edge across starts there */
#define PBW__EDGE_END(x) PBW__PICK(x, 2, 0, 1, 2) /* and ends there */
#define PBW__CORNERS2(to, from, corner) /* rows of finite vertices of the plane, in another order */ \
    to.x = corner((from).x), to.y = corner((from).y), to.z = to.ghost = pbw__splat(0.0), \
    to.lift = corner((from).lift), to.height = corner((from).height)

/* dim, weighted and, where it counts, the width of records are constants. */
PBW__SIMD_INLINE pbw__point4 pbw__point4_of(const double *p, int dim, int weighted, size_t width)
{
    pbw__point4 point;
    point.x = pbw__splat(p[0]);
    point.y = pbw__splat(p[1]);
    point.z = pbw__splat(dim == 3 ? p[2] : 0.0);
    point.weight = pbw__splat(p[dim]);
    point.p = p;
    point.width = width;
    point.dim = dim;
    point.weighted = weighted;
    return point;
}

PBW__SIMD_INLINE pbw__rows4 pbw__rows4_of(const double *record, const pbw_index *v, int hull, const pbw__point4 *p)
{
    const int dim = p->dim;
    const size_t step = p->width;
    const double *a = record + step * v[0], *b = record + step * v[1], *c = record + step * v[2],
                 *d = record + step * v[3];
    pbw__d4 x, y, z = pbw__splat(0.0), w = z, skipped;
    pbw__rows4 rows;
    pbw__columns(a, b, c, d, &x, &y);
    if (dim == 3 && p->weighted) {
        pbw__columns(a + 2, b + 2, c + 2, d + 2, &z, &w);
    } else if (dim == 3) {                           /* without weights z is the last of the record */
        pbw__columns(a + 1, b + 1, c + 1, d + 1, &skipped, &z);
    } else if (p->weighted) {
        w = pbw__four(a[2], b[2], c[2], d[2]);
    }
    rows.x = x - p->x;
    rows.y = y - p->y;
    rows.z = z - p->z;
    rows.ghost = pbw__splat(0.0);
    if (hull) {                                      /* the ghost's record is at infinity */
        rows.ghost = pbw__equal(x, pbw__splat(HUGE_VAL));
        rows.x = pbw__andnot4(rows.ghost, rows.x);
        rows.y = pbw__andnot4(rows.ghost, rows.y);
        rows.z = dim == 3 ? pbw__andnot4(rows.ghost, rows.z) : rows.z;
    }
    rows.lift = pbw__fma(rows.y, rows.y, rows.x * rows.x);
    if (dim == 3) {
        rows.lift = pbw__fma(rows.z, rows.z, rows.lift);
    }
    rows.height = rows.lift;
    if (p->weighted) {
        pbw__d4 weight = pbw__andnot4(rows.ghost, w - p->weight);
        rows.lift = rows.lift - weight;
        rows.height = rows.height + pbw__abs4(weight);
    }
    return rows;
}

/* Gives the ghost's row the lift and the height W of >>cavity3 and >>cavity2. */
PBW__SIMD_INLINE void pbw__lift_ghosts(pbw__rows4 *rows, pbw__d4 height)
{
    rows->lift = pbw__blend_zero(rows->lift, rows->ghost, height);
    rows->height = pbw__blend_zero(rows->height, rows->ghost, height);
}
#endif

/* Returns the first facet of a finite simplex that has p strictly outside, exactly; dim+1 if there is none.  Facets
   in `inner` are known to have it inside. */
static PBW__NOINLINE unsigned pbw__exit(const pbw__kernel *kernel, pbw_index t, const double *p, unsigned inner)
{
    const double *x[4];
    int i;
    pbw__corners_of(kernel, t, x);
    for (i = 0; i <= kernel->dim; i++) {
        if ((inner >> i & 1) == 0 && pbw__side(kernel->dim, x, i, p, kernel->grid) < 0) {
            break;
        }
    }
    return (unsigned)i;
}

/* Returns t, or the simplex across from its ghost vertex: walks start at finite simplices. */
PBW__INLINE pbw_index pbw__walk_start(const pbw__kernel *kernel, pbw_index t, int dim)
{
    size_t last = 4 * (size_t)t + (size_t)dim;
    return kernel->corner[last] == PBW__GHOST ? (pbw_index)(kernel->link[last] >> 2) : t;
}

/* Returns a simplex in conflict with p, or PBW_NONE if p is hidden. */
PBW__INLINE pbw_index pbw__locate_of(pbw__kernel *kernel, pbw_index t, const double *p, int dim)
{
    const unsigned corners = (unsigned)dim + 1;
    for (t = pbw__walk_start(kernel, t, dim); ; ) {
        const pbw_index *v = kernel->corner + 4 * (size_t)t;
        double u[4][4], side, bound, limit, square, lowest = 0.0, power = 0.0, height = 1e-55;
        unsigned i, exit = corners, inner = 0;
        kernel->statistics.walk_steps++;
        if (v[dim] == PBW__GHOST) {
            return t;
        }
        for (i = 0; i < corners; i++) {
            height = pbw__max(height, pbw__row(kernel, v[i], p, u[i], dim));
        }
        square = height * height;
        bound = square * (dim == 3 ? height * (PBW__ORIENT3_ERROR * PBW__ORIENT3_ERROR)
                                   : PBW__ORIENT2_ERROR * PBW__ORIENT2_ERROR);
        limit = square * square * (dim == 3 ? height * (PBW__SPHERE_ERROR * PBW__SPHERE_ERROR)
                                            : PBW__CIRCLE_ERROR * PBW__CIRCLE_ERROR);
        for (i = 0; i < corners; i++) {
            const unsigned char *corner = pbw__facet_corners[i] + 1;
            const double *a = u[dim == 3 ? corner[0] : (i + 1) % 3], *b = u[dim == 3 ? corner[1] : (i + 2) % 3];
            side = dim == 3 ? pbw__det3(a, b, u[corner[2]]) : a[0] * b[1] - a[1] * b[0];
            power += u[i][dim] * side;
            if (side * side > bound) {
                inner |= (unsigned)(side > 0.0) << i;
                if (side < lowest) {
                    lowest = side;
                    exit = i;
                }
            }
        }
        if (power > 0.0 && power * power > limit) {
            return t;
        }
        if (exit == corners) {
            exit = pbw__exit(kernel, t, p, inner);
            if (exit == corners) {                   /* inside; only a weighted point can then be out of conflict */
                return !kernel->weighted || pbw__in_conflict(kernel, t, p) ? t : PBW_NONE;
            }
        }
        if (PBW__UNLIKELY(kernel->own.owner != NULL) && !pbw__may_cross(kernel, t, exit)) {
            kernel->last = t;
            return PBW__FOREIGN;
        }
        t = (pbw_index)(kernel->link[4 * (size_t)t + exit] >> 2);
    }
}

#ifdef PBW__SIMD
/* pbw__locate_of with vectors, a facet in each lane. */
PBW__SIMD_INLINE pbw_index pbw__locate3_simd(pbw__kernel *kernel, pbw_index t, const pbw__point4 *point)
{
    const double *p = point->p;
    t = pbw__walk_start(kernel, t, 3);
    for (;;) {
        const pbw_index *v = kernel->corner + 4 * (size_t)t;
        pbw__d4 ax, ay, az, bx, by, bz, cx, cy, cz, side, lowest, power, h, square, rounded, bound, limit;
        pbw__rows4 r;
        unsigned outer, exit;
        kernel->statistics.walk_steps++;
        if (v[3] == PBW__GHOST) {
            return t;
        }
        r = pbw__rows4_of(kernel->record, v, 0, point);
        ax = PBW__CORNER_A(r.x), ay = PBW__CORNER_A(r.y), az = PBW__CORNER_A(r.z);
        bx = PBW__CORNER_B(r.x), by = PBW__CORNER_B(r.y), bz = PBW__CORNER_B(r.z);
        cx = PBW__CORNER_C(r.x), cy = PBW__CORNER_C(r.y), cz = PBW__CORNER_C(r.z);
        side = ax * pbw__det2(by, bz, cy, cz);
        side = pbw__fnma(ay, pbw__det2(bx, bz, cx, cz), side);
        side = pbw__fma(az, pbw__det2(bx, by, cx, cy), side);
        power = pbw__sum_lanes(r.lift * side);
        h = pbw__max4(pbw__max_lane(r.height), pbw__splat(1e-55));
        square = h * h;
        rounded = pbw__at_least(h, pbw__splat(kernel->exact_height));
        bound = pbw__and4(rounded, square * h * pbw__splat(PBW__ORIENT3_ERROR * PBW__ORIENT3_ERROR));
        limit = pbw__and4(rounded, square * square * h * pbw__splat(PBW__SPHERE_ERROR * PBW__SPHERE_ERROR));
        if (pbw__first(power) > 0.0 && pbw__first(power * power) > pbw__first(limit)) {
            return t;
        }
        lowest = pbw__min_lane(side);
        outer = pbw__signs(pbw__equal(side, lowest));
        exit = (unsigned)__builtin_ctz(outer | 16u);
        if (PBW__UNLIKELY(!(pbw__first(lowest) < 0.0 && pbw__first(lowest * lowest) > pbw__first(bound)))) {
            unsigned inner = pbw__signs(pbw__greater(side * side, bound));
            inner &= pbw__signs(side) ^ 15u;
            exit = pbw__signs(rounded) == 0 ? 4 : pbw__exit(kernel, t, p, inner);
            if (exit == 4) {
                return !point->weighted || pbw__in_conflict(kernel, t, p) ? t : PBW_NONE;
            }
        }
        if (PBW__UNLIKELY(kernel->own.owner != NULL) && !pbw__may_cross(kernel, t, exit)) {
            kernel->last = t;
            return PBW__FOREIGN;
        }
        t = (pbw_index)(kernel->link[4 * (size_t)t + exit] >> 2);
    }
}

/* Returns the bound on the error of an in-circle determinant of rows no higher than h. */
PBW__SIMD_INLINE pbw__d4 pbw__circle_limit(pbw__d4 h)
{
    return pbw__splat(8.0) * h * h * pbw__splat(PBW__CIRCLE_ERROR / 8.0);
}

/* Returns a number that is positive if p is to the right of the line from a to b; its error is below *error. */
PBW__INLINE double pbw__right_of(const double *a, const double *b, const double *p, double *error)
{
    const double ax = a[0] - p[0], ay = a[1] - p[1], bx = b[0] - p[0], by = b[1] - p[1];
    const double height = pbw__max(pbw__max(ax * ax + ay * ay, bx * bx + by * by), 1e-140);
    *error = height * PBW__ORIENT2_ERROR;
    return ax * by - ay * bx;
}

/* Walks along the hull from ghost t.  Returns a ghost with p certainly beyond its edge, or PBW_NONE if none is
   near. */
PBW__INLINE pbw_index pbw__walk_hull(pbw__kernel *kernel, pbw_index t, const double *p)
{
    int steps;
    for (steps = 0; steps < 16; steps++) {
        const double *a = pbw__record_at(kernel, kernel->corner[4 * (size_t)t]);
        const double *b = pbw__record_at(kernel, kernel->corner[4 * (size_t)t + 1]);
        const double x = b[0] - a[0], y = b[1] - a[1];
        const int past_a = (a[0] - p[0]) * x + (a[1] - p[1]) * y > 0.0;
        const int past_b = (b[0] - p[0]) * x + (b[1] - p[1]) * y < 0.0;
        double error;
        kernel->statistics.walk_steps++;
        if (pbw__right_of(a, b, p, &error) > error) {
            return t;
        }
        if (past_a == past_b
            || (PBW__UNLIKELY(kernel->own.owner != NULL) && !pbw__may_cross(kernel, t, (unsigned)past_a))) {
            break;
        }
        t = (pbw_index)(kernel->link[4 * (size_t)t + (size_t)past_a] >> 2);
    }
    return PBW_NONE;
}

/* The walk in the plane with vectors, an edge in each lane.  *rows: those of a finite triangle; the fourth is the
   first again.  Leaves through the edge that maximises (distance outside) x (distance of the opposite corner): with
   the distance outside alone, a long thin triangle with p near a corner would be left through the far edge. */
PBW__SIMD_INLINE pbw_index pbw__locate2_simd(pbw__kernel *kernel, pbw_index t, const pbw__point4 *point,
                                             pbw__rows4 *rows)
{
    const pbw_index *corner = kernel->corner;
    const double *p = point->p;
    size_t steps = 1;
    if (PBW__UNLIKELY(corner[4 * (size_t)t + 2] == PBW__GHOST)) {
        pbw_index ghost = pbw__walk_hull(kernel, t, p);
        if (ghost != PBW_NONE) {
            return ghost;
        }
    }
    for (t = pbw__walk_start(kernel, t, 2); ; steps++) {
        const pbw_index *v = corner + 4 * (size_t)t;
        pbw__d4 sx, sy, sh, ex, ey, eh, side, power, h, bound, outer, far;
        unsigned exits, exit;
        if (v[2] == PBW__GHOST) {
            break;
        }
        {
            const pbw_index four[4] = { v[0], v[1], v[2], v[0] };
            *rows = pbw__rows4_of(kernel->record, four, 0, point);
        }
        sx = PBW__EDGE_START(rows->x), sy = PBW__EDGE_START(rows->y), sh = PBW__EDGE_START(rows->height);
        ex = PBW__EDGE_END(rows->x), ey = PBW__EDGE_END(rows->y), eh = PBW__EDGE_END(rows->height);
        side = pbw__det2(sx, sy, ex, ey);
        h = pbw__max4(pbw__max4(rows->height, pbw__splat(1e-140)), pbw__max4(sh, eh));
        power = pbw__sum_lanes(pbw__drop_last(rows->lift * side));
        if (pbw__first(power) > pbw__first(pbw__circle_limit(h))) {
            break;
        }
        bound = h * pbw__splat(PBW__ORIENT2_ERROR);
        outer = pbw__greater(-side, bound);
        far = pbw__and4(outer, rows->height * -side);
        exits = pbw__signs(outer) & pbw__signs(pbw__equal(far, pbw__max_lane(far)));
        exit = (unsigned)__builtin_ctz(exits | 8u);
        if (PBW__UNLIKELY(exits == 0)) {
            unsigned inner = pbw__signs(pbw__greater(side, bound));
            exit = pbw__first(h) < kernel->exact_height ? 3 : pbw__exit(kernel, t, p, inner);
            if (exit == 3) {
                t = !point->weighted || pbw__in_conflict(kernel, t, p) ? t : PBW_NONE;
                break;
            }
        }
        if (PBW__UNLIKELY(kernel->own.owner != NULL) && !pbw__may_cross(kernel, t, exit)) {
            kernel->last = t;
            t = PBW__FOREIGN;
            break;
        }
        t = (pbw_index)(kernel->link[4 * (size_t)t + exit] >> 2);
    }
    kernel->statistics.walk_steps += steps;
    return t;
}
#endif

/* Returns where the walk to a vertex starts. */
PBW__INLINE pbw_index pbw__insert_start(pbw__kernel *kernel, pbw_index vertex)
{
    size_t region = vertex >> kernel->store->region_bits;
    if (PBW__UNLIKELY(region != kernel->slots.region)) {
        pbw__enter_region(kernel, region);
    }
    return kernel->last != PBW_NONE ? kernel->last : PBW__FOREIGN;
}

/* Ends a walk at t.  Returns PBW_OK or PBW__DEFERRED; the next walk begins at t if the vertex is left. */
PBW__INLINE pbw_status pbw__located(pbw__kernel *kernel, pbw_index t)
{
    kernel->last = t < PBW__FOREIGN ? t : kernel->last;
    if (t == PBW__FOREIGN || (t != PBW_NONE && kernel->own.owner != NULL && !pbw__may_delete(kernel, t))) {
        return PBW__DEFERRED;
    }
    return PBW_OK;
}
/* ------------------------------------------------------------------------------------------------------
   >>cavity3      In space: carve every simplex in conflict with the point, refill with the point's star.
   In: a simplex in conflict.  Out: the star of the new vertex.   (Bowyer 1981, Watson 1981)
   Holds before and after: the invariants of >>mesh.

   The search takes one simplex of the cavity after the other and tests its four neighbours at once.
     1. The neighbour across facet i is this simplex with corner i replaced by the far vertex o: with rows
        (x, y, z, lift) relative to the point, it is in conflict exactly if det(rows, row i replaced by o's) > 0.
     2. Expanded along row i this is a dot product of o's row with four cofactors, and the cofactors of the four
        facets share their 2x2 minors.
     3. A ghost vertex has the row (0, 0, 0, W), any W > 0: the same determinant is then W times the orientation that
        a ghost's conflict asks for.  W is the height of the simplex, so that it fits the bound.
     4. Vertices of the cavity get local numbers: a small table indexed by pairs of them links the star.
     5. A simplex has three vertices in common with the one that it was met from, and the fourth was the far vertex
        there: vectors take rows and numbers over, with one lane replaced, in the order of the corners in memory.

   Errors: see >>predicates, where what the bound leaves open goes.  Compared as det^2 with the square of the bound, h
   raised to 1e-55 if it is less; above 4e61 the product h^5, computed first, is infinite and nothing exceeds it.

   Small grids.  On a common grid (>>grid) the rows and all partial results are integers in its unit, none larger than
   the sum of the absolute products, 24 H^(5/2) for a height of H units^2.  With H < 6.5e5 that is below 2^53: nothing
   is rounded, and zero is a tie.  2D: 6 H^2, H < 3.8e7.  Lattices and coarse scans live on this.
   ------------------------------------------------------------------------------------------------------ */
/* Returns the local number of a vertex.  Whether the vertex is new is unpredictable, so the only branch is for
   collisions, which are rare.  They take one comparison: compilers make two branches of two. */
PBW__INLINE uint32_t pbw__local(uint64_t *table, uint64_t stamp, uint32_t *count, pbw_index v)
{
    const uint64_t key = stamp | (uint64_t)v * PBW__LOCALS;
    uint64_t *at = table + ((v * 0x9e3779b1u) >> 22), found;
    uint32_t number;
    for (found = *at ^ key; PBW__UNLIKELY(found - PBW__LOCALS < PBW__STAMP - PBW__LOCALS); found = *at ^ key) {
        at = at + 1 < table + PBW__TABLE ? at + 1 : table;
    }
    number = found < PBW__LOCALS ? (uint32_t)found : *count;
    *count += found >= PBW__LOCALS;
    *at = key | number;
    return number;
}

/* The state of a search, with copies of the kernel's pointers that the compiler can keep in registers. */
typedef struct pbw__search {
    const pbw_index *corner;
    const pbw__link *link;
    unsigned char *mark;
    pbw_index *cavity;
    pbw__carved *carved;
    pbw_index *from, *parent;
    uint64_t *table;
    size_t cavity_count, facet_count, capacity, room_until;
    uint64_t stamp;
    uint32_t local_count;
} pbw__search;

PBW__INLINE void pbw__search_lists(const pbw__kernel *kernel, pbw__search *search)
{
    search->cavity = kernel->scratch.cavity;
    search->carved = kernel->scratch.carved;
    search->from = kernel->scratch.from;
    search->parent = kernel->scratch.parent;
    search->capacity = kernel->scratch.from_capacity;        /* the last of the lists to grow */
}

PBW__INLINE void pbw__search_begin(pbw__kernel *kernel, pbw__search *search, pbw_index t)
{
    if (PBW__UNLIKELY(++kernel->scratch.stamp == PBW__STAMPS)) {
        memset(kernel->scratch.table, 0, PBW__TABLE * sizeof(uint64_t));
        kernel->scratch.stamp = 1;
    }
    search->corner = kernel->corner;
    search->link = kernel->link;
    search->mark = kernel->mark;
    search->table = kernel->scratch.table;
    pbw__search_lists(kernel, search);
    search->cavity_count = 1;
    search->facet_count = search->room_until = 0;
    search->stamp = kernel->scratch.stamp * PBW__STAMP;
    search->local_count = 1;                         /* number 0 stands for none */
    search->parent[0] = 4;                           /* the first was met from nowhere: the second stands in */
    search->carved[1].link[0] = (pbw__link)t * 4;
    search->mark[t] = 1;
}

/* Returns the link to the i-th simplex of the cavity from the one through which it was reached. */
PBW__INLINE pbw__link pbw__search_take(pbw__search *search, size_t i)
{
    pbw_index facet = search->parent[i];
    pbw__link link = search->carved[facet >> 2].link[facet & 3];
    search->cavity[i] = (pbw_index)(link >> 2);
    return link;
}

/* Abandons a search of `count` simplices at the i-th.  Its own pbw__search lets the caller's stay in registers. */
static PBW__NOINLINE pbw_status pbw__search_leave(pbw__kernel *kernel, size_t count, size_t i)
{
    pbw__search search;
    pbw__search_lists(kernel, &search);
    while (++i < count) {
        (void)pbw__search_take(&search, i);
    }
    return pbw__leave_cavity(kernel, count);
}

PBW__INLINE void pbw__search_end(pbw__kernel *kernel, const pbw__search *search)
{
    kernel->scratch.cavity_count = search->cavity_count;
    kernel->scratch.facet_count = search->facet_count;
    kernel->scratch.local_count = search->local_count;
    kernel->statistics.conflict_tests += search->cavity_count + search->facet_count - 1;
}

/* Makes room for the neighbours of the i-th simplex.  A simplex adds at most four items to the two lists together,
   and each list has room for the items of both: none can be full before simplex `room_until`. */
PBW__INLINE int pbw__search_room(pbw__kernel *kernel, pbw__search *search, size_t i)
{
    const size_t needed = search->cavity_count + search->facet_count + 8;
    if (PBW__LIKELY(i < search->room_until)) {
        return 1;
    }
    if (needed > search->capacity && !pbw__grow_lists(kernel, needed)) {
        return 0;
    }
    pbw__search_lists(kernel, search);
    search->room_until = i + (search->capacity - needed) / 4 + 1;
    return 1;
}

/* Notes the i-th simplex of the cavity, where the link leads, and numbers its corners. */
PBW__INLINE void pbw__search_number(pbw__search *search, size_t i, pbw__link link)
{
    size_t first = (size_t)(link & ~(pbw__link)3);
    pbw__carved *carved = search->carved + i;
    memcpy(carved->v, search->corner + first, sizeof(carved->v));
    memcpy(carved->link, search->link + first, sizeof(carved->link));
    if (PBW__LIKELY(search->local_count <= PBW__LOCALS - 4)) {
        carved->local[0] = pbw__local(search->table, search->stamp, &search->local_count, carved->v[0]);
        carved->local[1] = pbw__local(search->table, search->stamp, &search->local_count, carved->v[1]);
        carved->local[2] = pbw__local(search->table, search->stamp, &search->local_count, carved->v[2]);
        carved->local[3] = pbw__local(search->table, search->stamp, &search->local_count, carved->v[3]);
    }
}

/* Appends the neighbour across a facet to the cavity or to its boundary.  Branchless: writes to both lists, and the
   verdict, which is unpredictable, moves one of the counts. */
PBW__INLINE void pbw__search_sort(pbw__search *search, pbw_index facet, pbw_index o, unsigned inside)
{
    unsigned unmarked = PBW__LOAD(search->mark + o) ^ 1u;
    inside &= unmarked;
    PBW__STORE(search->mark + o, (unsigned char)(unmarked ^ 1u ^ inside));
    search->parent[search->cavity_count] = facet;
    search->cavity_count += inside;
    search->from[search->facet_count] = facet;
    search->facet_count += unmarked ^ inside;
}

#ifdef PBW__SIMD
/* Shuffles that bring the lanes of a set of four to the front. */
#define PBW__LANE(i) 4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3
static const unsigned char pbw__front[16][16] = {
    { 0 }, { PBW__LANE(0) }, { PBW__LANE(1) }, { PBW__LANE(0), PBW__LANE(1) }, { PBW__LANE(2) },
    { PBW__LANE(0), PBW__LANE(2) }, { PBW__LANE(1), PBW__LANE(2) }, { PBW__LANE(0), PBW__LANE(1), PBW__LANE(2) },
    { PBW__LANE(3) }, { PBW__LANE(0), PBW__LANE(3) }, { PBW__LANE(1), PBW__LANE(3) },
    { PBW__LANE(0), PBW__LANE(1), PBW__LANE(3) }, { PBW__LANE(2), PBW__LANE(3) },
    { PBW__LANE(0), PBW__LANE(2), PBW__LANE(3) }, { PBW__LANE(1), PBW__LANE(2), PBW__LANE(3) },
    { PBW__LANE(0), PBW__LANE(1), PBW__LANE(2), PBW__LANE(3) }
};

/* The lanes of a set of four: 1 for each that is in it. */
static const unsigned char pbw__lane_bits[16][4] = {
    { 0, 0, 0, 0 }, { 1, 0, 0, 0 }, { 0, 1, 0, 0 }, { 1, 1, 0, 0 }, { 0, 0, 1, 0 }, { 1, 0, 1, 0 }, { 0, 1, 1, 0 },
    { 1, 1, 1, 0 }, { 0, 0, 0, 1 }, { 1, 0, 0, 1 }, { 0, 1, 0, 1 }, { 1, 1, 0, 1 }, { 0, 0, 1, 1 }, { 1, 0, 1, 1 },
    { 0, 1, 1, 1 }, { 1, 1, 1, 1 }
};

/* pbw__search_sort for all four neighbours, which are different simplices: two simplices share at most one facet.
   Prefetches the links of those that stay: the refill writes there. */
PBW__SIMD_INLINE void pbw__search_sort4(pbw__search *search, pbw_index facet, const pbw__link *link, unsigned inside)
{
    unsigned char *mark = search->mark;
    const pbw_index o0 = (pbw_index)(link[0] >> 2), o1 = (pbw_index)(link[1] >> 2);
    const pbw_index o2 = (pbw_index)(link[2] >> 2), o3 = (pbw_index)(link[3] >> 2);
    unsigned marked = PBW__LOAD(mark + o0) + 2u * PBW__LOAD(mark + o1)
                    + 4u * (PBW__LOAD(mark + o2) + 2u * PBW__LOAD(mark + o3)), outside;
    const pbw__i4 lanes = { 0, 1, 2, 3 }, from = pbw__splat_i((int32_t)facet) + lanes;
    PBW__PREFETCH(search->link + link[0]);
    PBW__PREFETCH(search->link + link[1]);
    PBW__PREFETCH(search->link + link[2]);
    PBW__PREFETCH(search->link + link[3]);
    outside = 15u ^ (inside | marked);
    inside &= ~marked;
    marked |= inside;
    PBW__STORE(mark + o0, pbw__lane_bits[marked][0]);
    PBW__STORE(mark + o1, pbw__lane_bits[marked][1]);
    PBW__STORE(mark + o2, pbw__lane_bits[marked][2]);
    PBW__STORE(mark + o3, pbw__lane_bits[marked][3]);
    pbw__store4(search->parent + search->cavity_count, pbw__shuffle4(from, pbw__front[inside]));
    search->cavity_count += pbw__count4(inside);
    pbw__store4(search->from + search->facet_count, pbw__shuffle4(from, pbw__front[outside]));
    search->facet_count += pbw__count4(outside);
}

/* Rows in pairs, without weights. */
typedef struct pbw__pairs4 { pbw__pair4 x, y, z, lift; pbw__d4 height, ghost; } pbw__pairs4;

PBW__SIMD_INLINE pbw__pairs4 pbw__pairs4_of(const double *record, const pbw_index *v, const pbw__point4 *p)
{
    const int dim = p->dim;
    const pbw__d4 zero = pbw__splat(0.0);
    const pbw__point4 origin = { zero, zero, zero, zero, NULL, p->width, dim, 0 };
    pbw__rows4 at = pbw__rows4_of(record, v, 1, &origin);
    pbw__pairs4 rows;
    rows.x = pbw__difference4(at.x, p->x, at.ghost);
    rows.y = pbw__difference4(at.y, p->y, at.ghost);
    rows.z = pbw__difference4(at.z, p->z, at.ghost);
    rows.lift = pbw__plus4(pbw__times4(rows.x, rows.x), pbw__times4(rows.y, rows.y));
    if (dim == 3) {
        rows.lift = pbw__plus4(rows.lift, pbw__times4(rows.z, rows.z));
    }
    rows.height = rows.lift.head;
    rows.ghost = at.ghost;
    return rows;
}

#define PBW__CORNERS4(to, from, corner) \
    to.x.head = corner(from.x.head), to.x.tail = corner(from.x.tail), \
    to.y.head = corner(from.y.head), to.y.tail = corner(from.y.tail), \
    to.z.head = corner(from.z.head), to.z.tail = corner(from.z.tail), \
    to.lift.head = corner(from.lift.head), to.lift.tail = corner(from.lift.tail)

/* The determinants of pbw__carve3_simd in pairs, without weights; v: the corners of a simplex, far: the vertices
   across its facets.  Returns which are certain; *inside: which are positive.
   With h above 1e-20 what underflows is far below the bound; above 4e61 h^5 is infinite. */
PBW__SIMD static PBW__NOINLINE unsigned pbw__power4_pairs(const pbw__kernel *kernel, const pbw_index *v,
                                                          const pbw_index *far, const double *p, unsigned *inside)
{
    const pbw__point4 point = pbw__point4_of(p, 3, 0, kernel->width);
    const double *record = kernel->record;
    pbw__pairs4 r = pbw__pairs4_of(record, v, &point), o = pbw__pairs4_of(record, far, &point), a, b, c;
    pbw__pair4 xy, xz, yz, xl, yl, zl, det;
    pbw__d4 height = pbw__max_lane(r.height), h = pbw__max4(height, o.height), limit = h * h;
    r.lift.head = pbw__blend_zero(r.lift.head, r.ghost, height);
    o.lift.head = pbw__blend_zero(o.lift.head, o.ghost, height);
    PBW__CORNERS4(a, r, PBW__CORNER_A);
    PBW__CORNERS4(b, r, PBW__CORNER_B);
    PBW__CORNERS4(c, r, PBW__CORNER_C);
    xy = pbw__cross4(b.x, b.y, c.x, c.y), xz = pbw__cross4(b.x, b.z, c.x, c.z);
    yz = pbw__cross4(b.y, b.z, c.y, c.z), xl = pbw__cross4(b.x, b.lift, c.x, c.lift);
    yl = pbw__cross4(b.y, b.lift, c.y, c.lift), zl = pbw__cross4(b.z, b.lift, c.z, c.lift);
    det = pbw__times4(o.x, pbw__sum4(a.y, zl, a.z, yl, a.lift, yz));
    det = pbw__minus4(det, pbw__times4(o.y, pbw__sum4(a.x, zl, a.z, xl, a.lift, xz)));
    det = pbw__plus4(det, pbw__times4(o.z, pbw__sum4(a.x, yl, a.y, xl, a.lift, xy)));
    det = pbw__minus4(det, pbw__times4(o.lift, pbw__sum4(a.x, yz, a.y, xz, a.z, xy)));
    det.head += det.tail;
    *inside = pbw__signs(det.head) ^ 15u;
    limit = limit * limit * h * pbw__splat(PBW__SPHERE_PAIRS_ERROR * PBW__SPHERE_PAIRS_ERROR);
    return pbw__signs(pbw__and4(pbw__greater(det.head * det.head, limit), pbw__greater(h, pbw__splat(1e-20))));
}

PBW__SIMD_INLINE pbw__d4 pbw__dot4(pbw__d4 x, pbw__d4 y, pbw__d4 z, pbw__d4 u, pbw__d4 v, pbw__d4 w)
{
    return pbw__fma(x, u, pbw__fma(y, v, z * w));
}

/* Returns the verdicts on ties, by the rule of pbw__conflict in >>predicates: of `count` vertices, with the
   coefficients that their lifts have in the determinant, the lexicographically largest with a coefficient other than
   zero decides if it is larger than p.  A key is the coordinates of a row in one number: integers of so few bits
   compare as they do one after the other. */
PBW__SIMD_INLINE unsigned pbw__break_ties(const pbw__d4 *key, const pbw__d4 *coefficient, int count)
{
    const pbw__d4 zero = pbw__splat(0.0);
    pbw__d4 largest = zero, verdict = zero;
    int i;
    for (i = 0; i < count; i++) {
        const pbw__d4 larger = pbw__andnot4(pbw__equal(coefficient[i], zero), pbw__greater(key[i], largest));
        largest = pbw__blend(largest, key[i], larger);
        verdict = pbw__blend(verdict, coefficient[i], larger);
    }
    return pbw__signs(pbw__greater(verdict, zero));
}

/* The verdicts where the determinants of pbw__carve3_simd are zero, nothing is rounded and the neighbours are finite.
   Coordinates are integers below EXACT_HEIGHT3^(1/2) < 2^10, differences of two below 2^11. */
PBW__SIMD static PBW__NOINLINE unsigned pbw__ties4(const pbw__kernel *kernel, const pbw_index *v,
                                                   const pbw_index *far, const double *p)
{
    const pbw__point4 point = pbw__point4_of(p, 3, 0, kernel->width);
    const double *record = kernel->record;
    const pbw__d4 zero = pbw__splat(0.0), radix = pbw__splat(2048.0);
    pbw__rows4 r = pbw__rows4_of(record, v, 1, &point);
    pbw__rows4 o = pbw__rows4_of(record, far, 1, &point);
    pbw__d4 ax = PBW__CORNER_A(r.x), ay = PBW__CORNER_A(r.y), az = PBW__CORNER_A(r.z);
    pbw__d4 bx = PBW__CORNER_B(r.x), by = PBW__CORNER_B(r.y), bz = PBW__CORNER_B(r.z);
    pbw__d4 cx = PBW__CORNER_C(r.x), cy = PBW__CORNER_C(r.y), cz = PBW__CORNER_C(r.z);
    pbw__d4 x = by * cz - bz * cy, y = bz * cx - bx * cz, z = bx * cy - by * cx;
    pbw__d4 key[4], coefficient[4];
    key[0] = pbw__fma(pbw__fma(r.x, radix, r.y), radix, r.z);
    key[3] = pbw__fma(pbw__fma(o.x, radix, o.y), radix, o.z);
    key[2] = PBW__CORNER_C(key[0]), key[1] = PBW__CORNER_B(key[0]), key[0] = PBW__CORNER_A(key[0]);
    coefficient[0] = pbw__dot4(x, y, z, o.x, o.y, o.z);
    coefficient[3] = zero - pbw__dot4(x, y, z, ax, ay, az);
    x = cy * az - cz * ay, y = cz * ax - cx * az, z = cx * ay - cy * ax;
    coefficient[1] = pbw__dot4(x, y, z, o.x, o.y, o.z);
    x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
    coefficient[2] = pbw__dot4(x, y, z, o.x, o.y, o.z);
    return pbw__break_ties(key, coefficient, 4);
}

/* Returns the exact verdicts on the neighbours of a simplex of the cavity that the filter left open (bits of
   `certain` not set).  Those without the bit in `rounded` are ties.  A ghost tied with a finite simplex is in
   conflict, as that is. */
PBW__SIMD static PBW__NOINLINE unsigned pbw__search_exact(pbw__kernel *kernel, const pbw__carved *carved,
                                                          unsigned certain, unsigned inside, unsigned rounded,
                                                          const double *p)
{
    const pbw_index *v = carved->v;
    pbw_index far[4];
    unsigned open = 0, ghost = 0, ghosts = 0, tied, k;
    PBW__PHASE(PBW__EXACT);
    for (k = 0; k < 4; k++) {
        far[k] = kernel->corner[carved->link[k]];
        ghost |= (unsigned)(v[k] == PBW__GHOST) << k;
        ghosts |= (unsigned)(far[k] == PBW__GHOST) << k;
        open |= (unsigned)!PBW__LOAD(kernel->mark + (carved->link[k] >> 2)) << k;
    }
    inside &= certain;
    open &= ~certain;
    tied = open & ~rounded & (ghost != 0 ? ghost : 15u);
    if (tied != 0) {
        inside |= tied & (ghosts | pbw__ties4(kernel, v, far, p));
        open &= ~tied;
        kernel->statistics.exact_tests += pbw__count4(tied);
    }
    if ((open & rounded) != 0 && !kernel->weighted) {
        unsigned positive;
        certain = open & rounded & pbw__power4_pairs(kernel, v, far, p, &positive);
        inside |= certain & positive;
        open &= ~certain;
        kernel->statistics.exact_tests += pbw__count4(certain);
    }
    for (k = 0; open >> k != 0; k++) {
        if ((open >> k & 1) != 0) {
            inside |= (unsigned)pbw__in_conflict(kernel, (pbw_index)(carved->link[k] >> 2), p) << k;
        }
    }
    PBW__PHASE(PBW__CAVITY);
    return inside;
}
#endif

/* Finds the cavity of p from t, a simplex in conflict: the scalar search. */
static pbw_status pbw__carve3_scalar(pbw__kernel *kernel, pbw_index t, const double *p)
{
    pbw__search search;
    size_t i;
    pbw__search_begin(kernel, &search, t);
    for (i = 0; i < search.cavity_count; i++) {
        const pbw__link *link;
        const pbw_index *v;
        double row[5][4], height = 0.0;
        unsigned k;
        if (!pbw__search_room(kernel, &search, i)) {
            return PBW_ERROR_MEMORY;
        }
        pbw__search_number(&search, i, pbw__search_take(&search, i));
        link = search.carved[i].link;
        v = search.carved[i].v;
        for (k = 0; k < 4; k++) {
            height = pbw__max(height, pbw__row(kernel, v[k], p, row[k], 3));
        }
        row[3][3] = v[3] == PBW__GHOST ? height : row[3][3];
        for (k = 0; k < 4; k++) {
            const unsigned char *corner = pbw__facet_corners[k] + 1;
            const double *o = row[4], *a = row[corner[0]], *b = row[corner[1]], *c = row[corner[2]];
            pbw_index far = search.corner[link[k]];
            double h, det, limit, xy, xz, yz, xl, yl, zl;
            unsigned inside;
            if (PBW__LOAD(search.mark + (link[k] >> 2))) {
                continue;
            }
            h = pbw__max(pbw__max(height, pbw__row(kernel, far, p, row[4], 3)), 1e-55);
            row[4][3] = far == PBW__GHOST ? height : row[4][3];
            xy = b[0] * c[1] - b[1] * c[0], xz = b[0] * c[2] - b[2] * c[0], yz = b[1] * c[2] - b[2] * c[1];
            xl = b[0] * c[3] - b[3] * c[0], yl = b[1] * c[3] - b[3] * c[1], zl = b[2] * c[3] - b[3] * c[2];
            det = o[0] * (a[1] * zl - a[2] * yl + a[3] * yz) - o[1] * (a[0] * zl - a[2] * xl + a[3] * xz)
                + o[2] * (a[0] * yl - a[1] * xl + a[3] * xy) - o[3] * (a[0] * yz - a[1] * xz + a[2] * xy);
            limit = h * h * (h * h) * h * (PBW__SPHERE_ERROR * PBW__SPHERE_ERROR);
            inside = det > 0.0;
            if (PBW__UNLIKELY(!(det * det > limit))) {
                inside = (unsigned)pbw__in_conflict(kernel, (pbw_index)(link[k] >> 2), p);
            }
            if (inside && kernel->own.owner != NULL && !pbw__may_delete(kernel, (pbw_index)(link[k] >> 2))) {
                return pbw__search_leave(kernel, search.cavity_count, i);
            }
            pbw__search_sort(&search, (pbw_index)(4 * i + k), (pbw_index)(link[k] >> 2), inside);
        }
    }
    pbw__search_end(kernel, &search);
    return PBW_OK;
}

#ifdef PBW__SIMD
/* The rows of the latest simplices of the cavity, and of the vertices across their facets.  Tests hold eight, so that
   they also reach simplices that are no longer held. */
#define PBW__HELD (PBW__SMALLER(64) < 64 ? 8 : 64)
typedef struct pbw__held { pbw__d4 x, y, z, lift, far_x, far_y, far_z, far_lift; } pbw__held;
typedef struct pbw__latest {
    pbw__held held[PBW__HELD];
    pbw__d4 heights[PBW__HELD][2];                   /* of weighted rows; else they are the lifts */
    unsigned char lacking[PBW__HELD];                /* >>parallel: the corners that are not ours, as a set */
} pbw__latest;

/* By lanes: all bits in lane k; the number m in lane k, at 4 * k + m. */
static const int64_t pbw__lane[4][4] = { { -1, 0, 0, 0 }, { 0, -1, 0, 0 }, { 0, 0, -1, 0 }, { 0, 0, 0, -1 } };
static const int32_t pbw__lane_number[16][4] = {
    { 0, 0, 0, 0 }, { 1, 0, 0, 0 }, { 2, 0, 0, 0 }, { 3, 0, 0, 0 }, { 0, 0, 0, 0 }, { 0, 1, 0, 0 }, { 0, 2, 0, 0 },
    { 0, 3, 0, 0 }, { 0, 0, 0, 0 }, { 0, 0, 1, 0 }, { 0, 0, 2, 0 }, { 0, 0, 3, 0 }, { 0, 0, 0, 0 }, { 0, 0, 0, 1 },
    { 0, 0, 0, 2 }, { 0, 0, 0, 3 }
};

/* pbw__search_number for the i-th simplex, met through a facet: it has three corners in common with the simplex
   behind that, and the fourth is the far vertex there.  Returns where each corner's row is among that simplex's, with
   the far one in place of the one across from the facet. */
PBW__SIMD_INLINE pbw__order4 pbw__search_inherit(pbw__search *search, size_t i, pbw_index facet, pbw__link link)
{
    const pbw__carved *parent = search->carved + (facet >> 2);
    pbw__carved *carved = search->carved + i;
    const size_t first = (size_t)(link & ~(pbw__link)3);
    const pbw__i4 v = pbw__load4(search->corner + first), old = pbw__load4(parent->v);
    const pbw__i4 is1 = v == PBW__PICK4(old, 1, 1, 1, 1);
    const pbw__i4 is2 = v == PBW__PICK4(old, 2, 2, 2, 2);
    const pbw__i4 is3 = v == PBW__PICK4(old, 3, 3, 3, 3);                    /* -1, which is 3 modulo 4 */
    const pbw__i4 place = ((is3 + (is2 + is2)) - is1) | pbw__load4(pbw__lane_number[4 * (link & 3) + (facet & 3)]);
    pbw__store4(carved->v, v);
    memcpy(carved->link, search->link + first, sizeof(carved->link));
    if (PBW__LIKELY(search->local_count < PBW__LOCALS)) {
        uint32_t number = pbw__local(search->table, search->stamp, &search->local_count, search->corner[link]);
        pbw__store4(carved->local, pbw__permute4(pbw__load4(parent->local), place));
        carved->local[link & 3] = number;
    }
    return pbw__order4_of(place);
}

/* Returns lanes of a, or of b in the lane masked, in an order that pbw__search_inherit found. */
PBW__SIMD_INLINE pbw__d4 pbw__take_over(pbw__d4 a, pbw__d4 b, pbw__d4 lane, pbw__order4 order)
{
    return pbw__reorder(pbw__blend(a, b, lane), order);
}

/* Takes the i-th simplex of the cavity, makes its rows and numbers its vertices; *entry: the link to it.  The ghost's
   row is raised, so that minors need not wait for the height.  Rows that an earlier simplex still has are copied. */
PBW__SIMD_INLINE pbw__rows4 pbw__carve_rows(pbw__search *search, size_t i, pbw__link *entry, const double *record,
                                            const pbw__point4 *point, const pbw__latest *latest)
{
    const pbw_index facet = search->parent[i];
    const pbw__link link = *entry = pbw__search_take(search, i);
    pbw__rows4 r;
    if (PBW__UNLIKELY(i - (facet >> 2) >= PBW__HELD)) {
        pbw__search_number(search, i, link);
        r = pbw__rows4_of(record, search->carved[i].v, 1, point);
        pbw__lift_ghosts(&r, pbw__max_lane(r.height));
    } else {
        const pbw__held *from = latest->held + (facet >> 2) % PBW__HELD;
        const pbw__d4 *heights = latest->heights[(facet >> 2) % PBW__HELD];
        const pbw__d4 lane = pbw__mask(pbw__lane[facet & 3]);
        const pbw__order4 order = pbw__search_inherit(search, i, facet, link);
        r.x = pbw__take_over(from->x, from->far_x, lane, order);
        r.y = pbw__take_over(from->y, from->far_y, lane, order);
        r.z = pbw__take_over(from->z, from->far_z, lane, order);
        r.lift = pbw__take_over(from->lift, from->far_lift, lane, order);
        r.height = point->weighted ? pbw__take_over(heights[0], heights[1], lane, order) : r.lift;
    }
    return r;
}

/* Returns the determinants of the neighbours: rows r of the simplex, rows o of the far vertices. */
PBW__SIMD_INLINE pbw__d4 pbw__sphere4(const pbw__rows4 *r, const pbw__rows4 *o)
{
    const pbw__d4 ax = PBW__CORNER_A(r->x), ay = PBW__CORNER_A(r->y), az = PBW__CORNER_A(r->z);
    const pbw__d4 bx = PBW__CORNER_B(r->x), by = PBW__CORNER_B(r->y), bz = PBW__CORNER_B(r->z);
    const pbw__d4 cx = PBW__CORNER_C(r->x), cy = PBW__CORNER_C(r->y), cz = PBW__CORNER_C(r->z);
    const pbw__d4 al = PBW__CORNER_A(r->lift), bl = PBW__CORNER_B(r->lift), cl = PBW__CORNER_C(r->lift);
    const pbw__d4 xy = pbw__det2(bx, by, cx, cy), xz = pbw__det2(bx, bz, cx, cz), yz = pbw__det2(by, bz, cy, cz);
    const pbw__d4 xl = pbw__det2(bx, bl, cx, cl), yl = pbw__det2(by, bl, cy, cl), zl = pbw__det2(bz, bl, cz, cl);
    pbw__d4 det = o->x * pbw__fma(al, yz, pbw__det2(ay, az, yl, zl));
    det = pbw__fnma(o->y, pbw__fma(al, xz, pbw__det2(ax, az, xl, zl)), det);
    det = pbw__fma(o->z, pbw__fma(al, xy, pbw__det2(ax, ay, xl, yl)), det);
    return pbw__fnma(o->lift, pbw__fma(az, xy, pbw__det2(ax, ay, xz, yz)), det);
}

/* The search with vectors, a facet in each lane. */
PBW__SIMD_INLINE pbw_status pbw__carve3_simd(pbw__kernel *kernel, pbw_index t, const pbw__point4 *point)
{
    const pbw__d4 exact_height = pbw__splat(kernel->exact_height);
    const pbw_index *corner = kernel->corner;
    const double *record = kernel->record;
    const int owned = kernel->own.owner != NULL;
    pbw__latest latest;
    pbw__search search;
    size_t i;
    pbw__search_begin(kernel, &search, t);
    for (i = 0; i < search.cavity_count; i++) {
        pbw__held *here = latest.held + i % PBW__HELD;
        pbw__link link;
        pbw__rows4 r, o;
        pbw__d4 height, det, h, limit, rounded;
        unsigned certain, inside;
        if (PBW__UNLIKELY(!pbw__search_room(kernel, &search, i))) {
            return PBW_ERROR_MEMORY;
        }
        r = pbw__carve_rows(&search, i, &link, record, point, &latest);
        height = pbw__max_lane(r.height);
        {
            const pbw__link *around = search.link + (link & ~(pbw__link)3);      /* carved->link is being written */
            const pbw_index far[4] = { corner[around[0]], corner[around[1]], corner[around[2]], corner[around[3]] };
            o = pbw__rows4_of(record, far, 1, point);
        }
        o.lift = pbw__blend_zero(o.lift, o.ghost, height);
        here->x = r.x, here->y = r.y, here->z = r.z, here->lift = r.lift;
        here->far_x = o.x, here->far_y = o.y, here->far_z = o.z, here->far_lift = o.lift;
        if (point->weighted) {
            latest.heights[i % PBW__HELD][0] = r.height;
            latest.heights[i % PBW__HELD][1] = pbw__blend_zero(o.height, o.ghost, height);
        }
        det = pbw__sphere4(&r, &o);
        h = pbw__max4(pbw__max4(height, o.height), pbw__splat(1e-55));
        limit = h * h;
        rounded = pbw__at_least(h, exact_height);
        limit = pbw__and4(rounded, limit * limit * h * pbw__splat(PBW__SPHERE_ERROR * PBW__SPHERE_ERROR));
        certain = pbw__signs(pbw__greater(det * det, limit));
        inside = pbw__signs(det) ^ 15u;
        if (PBW__UNLIKELY(certain != 15)) {
            inside = pbw__search_exact(kernel, search.carved + i, certain, inside, pbw__signs(rounded), point->p);
        }
        if (PBW__UNLIKELY(owned)) {                  /* three corners are also corners of the simplex met before */
            const pbw__carved *carved = search.carved + i;
            const size_t met = search.parent[i] >> 2;
            const unsigned lack = i - met < PBW__HELD && latest.lacking[met % PBW__HELD] == 0
                                ? (pbw__is_ours(kernel, corner[link]) ^ 1u) << (link & 3)
                                : pbw__lacking4(kernel, carved->v[0], carved->v[1], carved->v[2], carved->v[3]);
            latest.lacking[i % PBW__HELD] = (unsigned char)lack;
            if (PBW__UNLIKELY(lack != 0) && (inside & ~lack) != 0
                && !pbw__may_delete_all(kernel, carved, lack, inside)) {
                return pbw__search_leave(kernel, search.cavity_count, i);
            }
        }
        pbw__search_sort4(&search, (pbw_index)(4 * i), search.carved[i].link, inside);
    }
    pbw__search_end(kernel, &search);
    return PBW_OK;
}
#endif

/* Joins the facets of the star of a large cavity.  An edge of the boundary belongs to two of them: the first leaves
   its corner in a hash, the second finds it there. */
static PBW__NOINLINE pbw_status pbw__sew3_wide(pbw__kernel *kernel)
{
    size_t size = 256, i;
    unsigned k;
    while (size < 3 * kernel->scratch.facet_count) {        /* 3 edges for 2 facets: at most half full */
        size *= 2;
    }
    if (size > kernel->scratch.wide_capacity
        && !PBW__RESIZE(&kernel->context->memory, &kernel->scratch, wide, size)) {
        return PBW_ERROR_MEMORY;
    }
    memset(kernel->scratch.wide, 0, size * sizeof(pbw__edge));     /* low == high: empty */
    for (i = 0; i < kernel->scratch.facet_count; i++) {
        const pbw_index *v = kernel->corner + 4 * (size_t)kernel->scratch.cavity[i];
        for (k = 1; k < 4; k++) {
            pbw_index a = v[k == 1 ? 3 : k - 1], b = v[k == 3 ? 1 : k + 1];
            pbw_index low = a < b ? a : b, high = a < b ? b : a;
            pbw__link here = (pbw__link)kernel->scratch.cavity[i] * 4 + k;
            size_t at = pbw__hash_entry((uint64_t)low << 32 | high, size);
            pbw__edge *edge = kernel->scratch.wide + at;
            while (edge->low != edge->high && (edge->low != low || edge->high != high)) {
                at = (at + 1) & (size - 1);
                edge = kernel->scratch.wide + at;
            }
            if (edge->low == edge->high) {
                edge->low = low;
                edge->high = high;
                edge->link = here;
            } else {
                kernel->link[here] = edge->link;
                kernel->link[edge->link] = here;
            }
        }
    }
    return PBW_OK;
}

/* Joins the vertex to each facet of the cavity's boundary: a simplex each, the vertex first.  The next walk starts at
   the one whose vertices are nearest along the curve: others may reach far. */
static PBW__NOINLINE pbw_status pbw__refill3(pbw__kernel *kernel, pbw_index vertex)
{
    pbw__scratch *scratch = &kernel->scratch;
    const size_t count = scratch->facet_count, side = scratch->local_count > PBW__FEW - 4 ? PBW__LOCALS : PBW__FEW;
    const int few = scratch->local_count <= PBW__LOCALS - 4;
    uint64_t least = UINT64_MAX;
    size_t i;
    unsigned k;
    if (few && !PBW__GROW(kernel, scratch, edge, side * side)) {
        return PBW_ERROR_MEMORY;
    }
    for (i = 0; i < count; i++) {
        const pbw__carved *carved = scratch->carved + (scratch->from[i] >> 2);
        const pbw_index *local = carved->local;
        const unsigned char *corner = pbw__facet_corners[scratch->from[i] & 3] + 1;
        pbw__link base = (pbw__link)scratch->cavity[i] * 4, beyond = carved->link[scratch->from[i] & 3];
        uint64_t apart = 0;
        PBW__STORE(kernel->mark + scratch->cavity[i], 0);
        kernel->corner[base] = vertex;
        kernel->link[base] = beyond;
        kernel->link[beyond] = base;
        for (k = 0; k < 3; k++) {
            const pbw_index v = carved->v[corner[k]];
            kernel->corner[base + k + 1] = v;
            apart += v < vertex ? vertex - v : v - vertex;
            if (few) {
                scratch->edge[local[corner[(k + 1) % 3]] * side + local[corner[(k + 2) % 3]]] = base + k + 1;
            }
        }
        kernel->last = apart < least ? scratch->cavity[i] : kernel->last;
        least = apart < least ? apart : least;
    }
    for (i = 0; few && i < count; i++) {
        const pbw_index *local = scratch->carved[scratch->from[i] >> 2].local;
        const unsigned char *corner = pbw__facet_corners[scratch->from[i] & 3] + 1;
        for (k = 0; k < 3; k++) {
            kernel->link[(pbw__link)scratch->cavity[i] * 4 + k + 1]
                = scratch->edge[local[corner[(k + 2) % 3]] * side + local[corner[(k + 1) % 3]]];
        }
    }
    return few ? PBW_OK : pbw__sew3_wide(kernel);
}

#ifdef PBW__SIMD
/* Shuffles for the new simplex on a facet: its pbw__facet_corners; beside each, the two others in 16 bits. */
static const unsigned char pbw__facet_shuffle[4][2][16] = {
    { { PBW__LANE(0), PBW__LANE(1), PBW__LANE(2), PBW__LANE(3) },
      { 0, 0, 0, 0, 8, 9, 12, 13, 12, 13, 4, 5, 4, 5, 8, 9 } },
    { { PBW__LANE(0), PBW__LANE(2), PBW__LANE(0), PBW__LANE(3) },
      { 0, 0, 0, 0, 0, 1, 12, 13, 12, 13, 8, 9, 8, 9, 0, 1 } },
    { { PBW__LANE(0), PBW__LANE(0), PBW__LANE(1), PBW__LANE(3) },
      { 0, 0, 0, 0, 4, 5, 12, 13, 12, 13, 0, 1, 0, 1, 4, 5 } },
    { { PBW__LANE(0), PBW__LANE(0), PBW__LANE(2), PBW__LANE(1) },
      { 0, 0, 0, 0, 8, 9, 4, 5, 4, 5, 0, 1, 0, 1, 8, 9 } }
};

/* The refill with vectors, a simplex in each. */
PBW__SIMD_INLINE pbw_status pbw__refill3_simd(pbw__kernel *kernel, pbw_index vertex)
{
    const pbw__i4 new_corner = pbw__splat_i((int32_t)vertex);
    pbw__carved *carved = kernel->scratch.carved;
    pbw_index *corners = kernel->corner;
    const pbw_index *cavity = kernel->scratch.cavity, *from = kernel->scratch.from;
    pbw__link *links = kernel->link, *edge = kernel->scratch.edge;
    unsigned char *mark = kernel->mark;
    size_t i, count = kernel->scratch.facet_count;
    uint64_t least = UINT64_MAX;                     /* how far along the curve; which facet */
    if (PBW__UNLIKELY(kernel->scratch.local_count > PBW__FEW - 4)) {
        return pbw__refill3(kernel, vertex);
    }
    for (i = 0; i < count; i++) {
        const pbw__carved *inside = carved + (from[i] >> 2);
        const unsigned char (*shuffle)[16] = pbw__facet_shuffle[from[i] & 3];
        const pbw__i4 v = pbw__lead(pbw__shuffle4(pbw__load4(inside->v), shuffle[0]), new_corner);
        const pbw__i4 pairs = pbw__shuffle4(pbw__load4(inside->local), shuffle[1]);
        pbw_index there[4];
        pbw_index slot = cavity[i];
        const size_t base = 4 * (size_t)slot, beyond = inside->link[from[i] & 3];
        const uint64_t apart = (uint64_t)pbw__apart4(v, new_corner) << 32 | i;
        PBW__STORE(mark + slot, 0);
        pbw__store4(corners + base, v);
        links[base] = (pbw__link)beyond;
        links[beyond] = (pbw__link)base;
        pbw__store4(there, pbw__dot_pairs(pairs, 64, 1));
        pbw__store4(kernel->scratch.back + 4 * i, pbw__dot_pairs(pairs, 1, 64));
        least = apart < least ? apart : least;
        edge[there[1]] = (pbw__link)(base + 1);
        edge[there[2]] = (pbw__link)(base + 2);
        edge[there[3]] = (pbw__link)(base + 3);
    }
    for (i = 0; i < count; i++) {
        const pbw_index *back = kernel->scratch.back + 4 * i;
        pbw__link *link = links + (pbw__link)cavity[i] * 4;
        link[1] = edge[back[1]];
        link[2] = edge[back[2]];
        link[3] = edge[back[3]];
    }
    kernel->last = cavity[(uint32_t)least];
    return PBW_OK;
}
#endif
/* ------------------------------------------------------------------------------------------------------
   >>cavity2      In the plane: carve every triangle in conflict with the point, refill with the point's star.
   In: a triangle in conflict.  Out: the star of the new vertex.   (Bowyer 1981, Watson 1981)
   Holds before and after: the invariants of >>mesh.

   Errors: see >>predicates; h is raised to 1e-140.  In vectors the triangle (o, e, s) across an edge s e has the
   determinant o.x (s.l e.y - e.l s.y) + o.y (e.l s.x - s.l e.x) - o.l (s.x e.y - e.x s.y).  There the bound is
   computed from 8 h h, which is infinite before a partial sum, of at most 6 h^2, can be.  What it leaves
   open goes to >>predicates.
   ------------------------------------------------------------------------------------------------------ */
/* Returns whether a triangle is in conflict with p. */
PBW__INLINE int pbw__test2(pbw__kernel *kernel, pbw_index t, const double *p)
{
    const pbw_index *v = kernel->corner + 4 * (size_t)t;
    double a[3], b[3], c[3], height, det, limit;
    kernel->statistics.conflict_tests++;
    height = pbw__max(pbw__row(kernel, v[0], p, a, 2), pbw__row(kernel, v[1], p, b, 2));
    height = pbw__max(height, pbw__row(kernel, v[2], p, c, 2));
    c[2] = v[2] == PBW__GHOST ? height : c[2];
    det = a[2] * (b[0] * c[1] - b[1] * c[0]) + b[2] * (c[0] * a[1] - c[1] * a[0])
        + c[2] * (a[0] * b[1] - a[1] * b[0]);
    height = pbw__max(height, 1e-140);
    limit = 8.0 * height * height * (PBW__CIRCLE_ERROR / 8.0);
    return det > limit || det < -limit ? det > 0.0 : pbw__in_conflict(kernel, t, p);
}

/* The corners of a triangle after and before this one: 1 2 0 and 2 0 1. */
static const pbw__link pbw__after[3] = { 0 ^ 1, 1 ^ 2, 0 ^ 2 }, pbw__before[3] = { 0 ^ 2, 0 ^ 1, 1 ^ 2 };
#define PBW__AFTER(link) ((link) ^ pbw__after[(link) & 3])
#define PBW__BEFORE(link) ((link) ^ pbw__before[(link) & 3])

/* Marks a triangle of the cavity by the highest bit of each corner, which no vertex has, or clears the mark: so the
   plane needs no memory for marks.  In space the next tests would wait for writes to addresses that depend on a
   verdict. */
PBW__INLINE void pbw__flip_mark2(pbw__kernel *kernel, pbw_index t)
{
    pbw_index *v = kernel->corner + 4 * (size_t)t;
    v[0] ^= PBW__MARK;
    v[1] ^= PBW__MARK;
    v[2] ^= PBW__MARK;
}

/* 2D.  A depth-first search that looks through the edges of each triangle counter-clockwise meets the boundary in
   cyclic order, so the star needs no table: each new triangle borders the one before.  An edge between two triangles
   of the cavity that is not the way one was reached is met twice and skipped. */
static pbw_status pbw__carve2(pbw__kernel *kernel, pbw_index t, const double *p)
{
    const pbw__link *links = kernel->link;
    pbw__scratch *scratch = &kernel->scratch;
    pbw_status status = PBW_OK;
    size_t stack_count = 3, i;
    int k;
    scratch->cavity[0] = t;
    scratch->cavity_count = 1;
    scratch->facet_count = 0;
    pbw__flip_mark2(kernel, t);
    for (k = 0; k < 3; k++) {
        scratch->stack[k] = links[4 * (size_t)t + 2 - (size_t)k];
    }
    while (stack_count > 0 && status == PBW_OK) {
        const pbw__link link = scratch->stack[--stack_count];
        const pbw_index o = (pbw_index)(link >> 2);
        const size_t needed = scratch->cavity_count + scratch->facet_count + 4;
        if ((kernel->corner[link] & PBW__MARK) != 0) {
            continue;
        }
        if (needed > scratch->stack_capacity && !pbw__grow_lists(kernel, needed)) {      /* stack: cavity_count + 2 */
            status = PBW_ERROR_MEMORY;
        } else if (!pbw__test2(kernel, o, p)) {
            scratch->beyond[scratch->facet_count++] = link;
        } else if (kernel->own.owner != NULL && !pbw__may_delete(kernel, o)) {
            status = PBW__DEFERRED;
        } else {
            pbw__flip_mark2(kernel, o);
            scratch->cavity[scratch->cavity_count++] = o;
            scratch->stack[stack_count++] = links[PBW__BEFORE(link)];
            scratch->stack[stack_count++] = links[PBW__AFTER(link)];
        }
    }
    for (i = 0; i < scratch->cavity_count; i++) {
        pbw__flip_mark2(kernel, scratch->cavity[i]);
    }
    return status;
}

static pbw_status pbw__refill2(pbw__kernel *kernel, pbw_index vertex)
{
    size_t count = kernel->scratch.facet_count, i;
    pbw_index last_start = kernel->corner[PBW__BEFORE(kernel->scratch.beyond[count - 1])];
    kernel->scratch.beyond[count] = kernel->scratch.beyond[0];
    for (i = 0; i < count; i++) {
        pbw__link beyond = kernel->scratch.beyond[i], base = (pbw__link)kernel->scratch.cavity[i] << 2;
        pbw_index *v = kernel->corner + base;
        pbw__link *n = kernel->link + base;
        pbw_index start = kernel->corner[PBW__BEFORE(beyond)];
        pbw_index end = kernel->corner[PBW__BEFORE(kernel->scratch.beyond[i + 1])];
        /* Corner numbers in (vertex, start, end), turned once if `start` is the ghost. */
        unsigned turn = start == PBW__GHOST, from = turn ? 2 : 1, to = turn ? 0 : 2;
        /* Across from `end` lies the triangle before, which ends where we begin: its corner across from us is its
           `start`. */
        unsigned before_from = last_start == PBW__GHOST ? 2 : 1, after_to = end == PBW__GHOST ? 0 : 2;
        v[turn] = vertex;
        v[from] = start;
        v[to] = end;
        n[turn] = beyond;
        n[to] = (pbw__link)kernel->scratch.cavity[i == 0 ? count - 1 : i - 1] << 2 | before_from;
        n[from] = (pbw__link)kernel->scratch.cavity[i + 1 == count ? 0 : i + 1] << 2 | after_to;
        kernel->link[beyond] = base | turn;
        last_start = start;
    }
    return PBW_OK;
}

#ifdef PBW__SIMD
/* The vector search, for cavities from which no vertex disappears, as without weights none does: then all vertices of
   the cavity are on its boundary and no triangle is met twice, so nothing is marked.
     1. The boundary is a ring of edges.  Edge i goes from start to end, counter-clockwise seen from inside; beyond is
        the link across it.
     2. When the triangle there joins the cavity, two edges replace this one, with the far vertex between them: the
        first keeps its number, the second follows it in the ring.
     3. The queue has the numbers of the edges to be tested, four at a time, and zeros behind them.
     4. The star is written last, and before it nothing of the triangulation: a cavity that does not fit the ring is
        left to pbw__carve2.

   The ghost vertex has the row (0, 0, W), W the height of the triangle, as in >>cavity3.  The search begins without
   ghosts and goes on in pbw__ring_hull once it meets one. */
#define PBW__RING 32

typedef struct pbw__ring {
    pbw_index start[PBW__RING];                      /* the edge ends where the next one starts */
    pbw_index slot[PBW__RING];                       /* of the cavity; then of the star */
    pbw__link beyond[PBW__RING];
    unsigned next[PBW__RING], count, tail, hull;     /* hull: the search has met the ghost vertex */
    unsigned char queue[2 * PBW__RING + 4];
} pbw__ring;

/* Four triangles (o, e, s), met across the edges s e. */
typedef struct pbw__triangles { pbw__rows4 s, e, o; } pbw__triangles;

/* Returns their determinants and a bound of the heights. */
PBW__SIMD_INLINE pbw__d4 pbw__circle4(const pbw__triangles *t, pbw__d4 *height)
{
    pbw__d4 det = t->o.y * pbw__det2(t->e.lift, t->s.lift, t->e.x, t->s.x);
    det = pbw__fma(t->o.x, pbw__det2(t->s.lift, t->e.lift, t->s.y, t->e.y), det);
    *height = pbw__max4(pbw__max4(t->s.height, t->e.height), pbw__max4(t->o.height, pbw__splat(1e-140)));
    return pbw__fnma(t->o.lift, pbw__det2(t->s.x, t->s.y, t->e.x, t->e.y), det);
}

/* Returns a tighter bound of the errors, which takes longer: the sum of the absolute products is far below 6 h^2
   where only some of the vertices are far from the point, as in the thin triangles of points on a curve.  An
   underflow, of a product of two or three rows or of a lift, is multiplied by two coordinates at most: less than
   1e-300 (1 + h). */
PBW__SIMD_INLINE pbw__d4 pbw__thin_limit(const pbw__triangles *t, pbw__d4 h)
{
    const pbw__d4 sx = pbw__abs4(t->s.x), sy = pbw__abs4(t->s.y), ex = pbw__abs4(t->e.x), ey = pbw__abs4(t->e.y);
    pbw__d4 sum = pbw__abs4(t->o.y) * pbw__fma(t->e.height, sx, t->s.height * ex);
    sum = pbw__fma(pbw__abs4(t->o.x), pbw__fma(t->s.height, ey, t->e.height * sy), sum);
    sum = pbw__fma(t->o.height, pbw__fma(sx, ey, sy * ex), sum) * pbw__splat(8.0);
    return pbw__fma(sum, pbw__splat(PBW__THIN_ERROR / 8.0), pbw__fma(h, pbw__splat(1e-300), pbw__splat(1e-300)));
}

/* Returns which of them are in conflict; in `certain` the lanes for which that is known.  At the hull triangles are
   often thin. */
PBW__SIMD_INLINE unsigned pbw__test2_simd(const pbw__triangles *t, int hull, unsigned *certain)
{
    pbw__d4 h, det = pbw__circle4(t, &h);
    *certain = pbw__signs(pbw__greater(pbw__abs4(det), hull ? pbw__thin_limit(t, h) : pbw__circle_limit(h)));
    return pbw__signs(det) ^ 15u;
}

/* Settles lanes that pbw__test2_simd left open, and returns them; their verdicts are in *inside.  Where nothing is
   rounded the sign is certain, and ties between finite vertices can be broken: coordinates are integers below
   EXACT_HEIGHT2^(1/2) < 2^13. */
PBW__SIMD static PBW__NOINLINE unsigned pbw__settle2_rows(pbw__kernel *kernel, const pbw__triangles *t,
                                                          unsigned open, unsigned *inside)
{
    const pbw__rows4 *const s = &t->s, *const e = &t->e, *const o = &t->o;
    const pbw__d4 zero = pbw__splat(0.0), radix = pbw__splat(16384.0);
    pbw__d4 h, det = pbw__circle4(t, &h), key[3], side[3];
    const pbw__d4 exact = pbw__greater(pbw__splat(kernel->exact_height), h);
    const pbw__d4 tied = pbw__and4(exact, pbw__equal(det, zero));
    const unsigned settled = pbw__signs(pbw__andnot4(tied, exact)) & open;
    const unsigned ties = open & pbw__signs(pbw__andnot4(pbw__or4(pbw__or4(s->ghost, e->ghost), o->ghost), tied));
    if (ties == 0) {
        return settled;
    }
    key[0] = pbw__fma(s->x, radix, s->y), side[0] = pbw__det2(o->x, o->y, e->x, e->y);
    key[1] = pbw__fma(e->x, radix, e->y), side[1] = pbw__det2(s->x, s->y, o->x, o->y);
    key[2] = pbw__fma(o->x, radix, o->y), side[2] = pbw__det2(e->x, e->y, s->x, s->y);
    *inside = (*inside & ~ties) | (pbw__break_ties(key, side, 3) & ties);
    kernel->statistics.exact_tests += pbw__count4(ties);
    return settled | ties;
}

/* Calls it where heights may be exact, with a copy of the rows, so that the compiler keeps them in memory only there.
   (And no vector is an argument of a call: gcc for Windows leaves those unaligned.) */
PBW__SIMD_INLINE unsigned pbw__settle2(pbw__kernel *kernel, const pbw__triangles *t, unsigned open, unsigned *inside)
{
    open &= pbw__signs(pbw__greater(pbw__splat(kernel->exact_height), t->o.height));
    if (open != 0) {
        const pbw__triangles copy = *t;
        unsigned verdicts = *inside;
        open = pbw__settle2_rows(kernel, &copy, open, &verdicts);
        *inside = verdicts;
    }
    return open;
}

/* The determinants of pbw__test2_simd in pairs, without weights; corner: starts, ends and far vertices of four edges.
   Returns which are certain; *inside: which are positive.
   With h above 1e-20 what underflows is far below the bound; above 1e154 h^2 is infinite. */
PBW__SIMD static PBW__NOINLINE unsigned pbw__circle4_pairs(const pbw__kernel *kernel, pbw_index corner[3][4],
                                                           const double *p, unsigned *inside)
{
    const pbw__point4 point = pbw__point4_of(p, 2, 0, kernel->width);
    const double *record = kernel->record;
    pbw__pairs4 s = pbw__pairs4_of(record, corner[0], &point), e = pbw__pairs4_of(record, corner[1], &point);
    pbw__pairs4 o = pbw__pairs4_of(record, corner[2], &point);
    pbw__d4 h = pbw__max4(pbw__max4(s.lift.head, e.lift.head), o.lift.head), size;
    pbw__pair4 det;
    s.lift.head = pbw__blend_zero(s.lift.head, s.ghost, h);
    e.lift.head = pbw__blend_zero(e.lift.head, e.ghost, h);
    o.lift.head = pbw__blend_zero(o.lift.head, o.ghost, h);
    det = pbw__sum4(o.x, pbw__cross4(s.lift, s.y, e.lift, e.y), o.y, pbw__cross4(s.lift, s.x, e.lift, e.x),
                    o.lift, pbw__cross4(e.x, e.y, s.x, s.y));
    det.head += det.tail;
    *inside = pbw__signs(det.head) ^ 15u;
    size = pbw__abs4(det.head);
    return pbw__signs(pbw__and4(pbw__greater(size, h * h * pbw__splat(PBW__CIRCLE_PAIRS_ERROR)),
                                pbw__greater(h, pbw__splat(1e-20))));
}

/* Returns the exact verdicts on the next edges of the queue, for lanes that are still open. */
static PBW__NOINLINE unsigned pbw__ring_exact(pbw__kernel *kernel, const pbw__ring *ring, unsigned head,
                                              unsigned open, const double *p)
{
    pbw_index corner[3][4];
    unsigned inside = 0, k;
    for (k = 0; k < 4; k++) {
        unsigned edge = ring->queue[head + k];
        corner[0][k] = ring->start[edge];
        corner[1][k] = ring->start[ring->next[edge]];
        corner[2][k] = kernel->corner[ring->beyond[edge]];
    }
    if (!kernel->weighted) {
        unsigned positive, certain = open & pbw__circle4_pairs(kernel, corner, p, &positive);
        inside = certain & positive;
        open &= ~certain;
    }
    for (k = 0; open >> k != 0; k++) {
        if (open >> k & 1) {
            pbw_index t = (pbw_index)(ring->beyond[ring->queue[head + k]] >> 2);
            inside |= (unsigned)pbw__in_conflict(kernel, t, p) << k;
        }
    }
    return inside;
}

/* Adds the triangles across some of the next edges in the queue to the cavity: `inside` is the set of these edges.
   Some of them may join the queue only now, as edges of the triangles before them.
   PBW__RING_OVERFLOW: with weights, a vertex was met again, and may become hidden. */
PBW__SIMD_INLINE pbw_status pbw__ring_split(pbw__kernel *kernel, pbw__ring *ring, unsigned head,
                                            unsigned inside, int weighted)
{
    const pbw_index *corner = kernel->corner;
    const pbw__link *link = kernel->link;
    unsigned count = ring->count, tail = ring->tail;
    for (; inside != 0; inside &= inside - 1) {
        unsigned edge = ring->queue[head + (unsigned)__builtin_ctz(inside)];
        pbw__link beyond = ring->beyond[edge];
        pbw_index far = corner[beyond];
        unsigned i, met = 0;
        for (i = 0; weighted && i < count; i++) {
            met |= ring->start[i] == far;
        }
        if (PBW__UNLIKELY(met)) {
            return PBW__RING_OVERFLOW;
        }
        if (PBW__UNLIKELY(kernel->own.owner != NULL) && far != PBW__GHOST && !pbw__owns(kernel, far)) {
            return PBW__DEFERRED;                        /* all others of the ring are ours, or the ghost */
        }
        ring->slot[count - 2] = (pbw_index)(beyond >> 2);
        ring->start[count] = far;
        ring->next[count] = ring->next[edge];
        ring->next[edge] = count;
        ring->beyond[edge] = link[PBW__AFTER(beyond)];
        ring->beyond[count] = link[PBW__BEFORE(beyond)];
        ring->queue[tail] = (unsigned char)edge;
        ring->queue[tail + 1] = (unsigned char)count;
        count++;
        tail += 2;
    }
    memset(ring->queue + tail, 0, 4);
    ring->count = count;
    ring->tail = tail;
    return PBW_OK;
}

/* Tests the triangles across the next edges of the queue; those in conflict join the cavity.
   PBW__RING_OVERFLOW: they may not fit the ring. */
PBW__SIMD_INLINE pbw_status pbw__ring_step(pbw__kernel *kernel, pbw__ring *ring, unsigned head,
                                           const pbw__triangles *t, const pbw__point4 *point, int hull)
{
    unsigned certain, inside = pbw__test2_simd(t, hull, &certain);
    unsigned all = pbw__first_lanes(ring->tail - head);
    inside &= all;
    if (PBW__UNLIKELY((certain & all) != all)) {
        PBW__PHASE(PBW__EXACT);
        certain |= pbw__settle2(kernel, t, all & ~certain, &inside);
        if ((certain & all) != all) {
            inside = (inside & certain) | pbw__ring_exact(kernel, ring, head, all & ~certain, point->p);
        }
        PBW__PHASE(PBW__CAVITY);
    }
    if (PBW__UNLIKELY(ring->count > PBW__RING - 4)) {
        return PBW__RING_OVERFLOW;
    }
    return pbw__ring_split(kernel, ring, head, inside, point->weighted);
}

PBW__SIMD static PBW__NOINLINE pbw_status pbw__ring_hull(pbw__kernel *kernel, pbw__ring *ring, unsigned head,
                                                         const double *p);

/* Tests the edges of the queue, from `head` on, until it is empty. */
PBW__SIMD_INLINE pbw_status pbw__ring_finish(pbw__kernel *kernel, pbw__ring *ring, unsigned head,
                                             const pbw__point4 *point, int hull)
{
    const pbw_index *corner = kernel->corner;
    const double *record = kernel->record;
    pbw_status status = PBW_OK;
    while (head < ring->tail && status == PBW_OK) {
        const unsigned char *queue = ring->queue + head;
        const unsigned i0 = queue[0], i1 = queue[1], i2 = queue[2], i3 = queue[3];
        const unsigned next = head + 4 < ring->tail ? head + 4 : ring->tail;
        const pbw_index start[4] = { ring->start[i0], ring->start[i1], ring->start[i2], ring->start[i3] };
        const pbw_index end[4] = { ring->start[ring->next[i0]], ring->start[ring->next[i1]],
                                   ring->start[ring->next[i2]], ring->start[ring->next[i3]] };
        const pbw_index far[4] = { corner[ring->beyond[i0]], corner[ring->beyond[i1]], corner[ring->beyond[i2]],
                                   corner[ring->beyond[i3]] };
        pbw__triangles t;
        if (!hull && PBW__UNLIKELY(far[0] == PBW__GHOST || far[1] == PBW__GHOST || far[2] == PBW__GHOST
                                   || far[3] == PBW__GHOST)) {
            return pbw__ring_hull(kernel, ring, head, point->p);
        }
        t.s = pbw__rows4_of(record, start, hull, point);
        t.e = pbw__rows4_of(record, end, hull, point);
        t.o = pbw__rows4_of(record, far, hull, point);
        if (hull) {
            const pbw__d4 h = pbw__max4(pbw__max4(t.s.height, t.e.height), t.o.height);
            pbw__lift_ghosts(&t.s, h);
            pbw__lift_ghosts(&t.e, h);
            pbw__lift_ghosts(&t.o, h);
        }
        status = pbw__ring_step(kernel, ring, head, &t, point, hull);
        head = next;
    }
    return status;
}

/* From a ghost of corners a and b: tests the triangle behind it, (c, b, a), and the two across its edges a c and c b,
   all at once.  Sets *head to the number of edges of the queue that are done, 0 if another ghost may be in conflict.
   The edges of the hull that have the point beyond them, or in line with them, follow one another: so this ghost is
   the only one if the point is strictly behind the next edge on either side.  Without weights. */
PBW__SIMD_INLINE pbw_status pbw__ring_start_hull(pbw__kernel *kernel, pbw__ring *ring, const pbw__point4 *point,
                                                 unsigned *head)
{
    const pbw_index *corner = kernel->corner;
    const pbw__link *link = kernel->link, behind = ring->beyond[2];
    const pbw_index a = ring->start[2], b = ring->start[0], c = corner[behind];
    const pbw_index far[4] = { c, corner[link[PBW__AFTER(behind)]], corner[link[PBW__BEFORE(behind)]], c };
    const pbw_index start[4] = { a, a, c, a }, end[4] = { b, c, b, b };
    const double *next = pbw__record_at(kernel, corner[ring->beyond[0]]);
    const double *last = pbw__record_at(kernel, corner[ring->beyond[1]]);
    double error[2];
    const double after = pbw__right_of(pbw__record_at(kernel, b), next, point->p, error);
    const double before = pbw__right_of(last, pbw__record_at(kernel, a), point->p, error + 1);
    const unsigned finite = 1u | (unsigned)(far[1] != PBW__GHOST) << 1 | (unsigned)(far[2] != PBW__GHOST) << 2;
    pbw__triangles t;
    unsigned certain, inside;
    t.o = pbw__rows4_of(kernel->record, far, 1, point);
    t.s = pbw__rows4_of(kernel->record, start, 0, point);
    t.e = pbw__rows4_of(kernel->record, end, 0, point);
    inside = pbw__test2_simd(&t, 1, &certain) & finite;
    if (!(after < -error[0] && before < -error[1]) || ((certain | ~finite) & 7) != 7) {
        return PBW_OK;
    }
    ring->queue[0] = 2;
    ring->tail = 1;
    *head = 1 + 2 * (inside & 1);
    return pbw__ring_split(kernel, ring, 0, (inside & 1) != 0 ? inside : 0, 0);
}

/* Finishes a search that has met the ghost vertex. */
PBW__SIMD static PBW__NOINLINE pbw_status pbw__ring_hull(pbw__kernel *kernel, pbw__ring *ring, unsigned head,
                                                         const double *p)
{
    const pbw__point4 point = pbw__point4_of(p, 2, kernel->weighted, kernel->width);
    pbw_status status = PBW_OK;
    ring->hull = 1;
    if (head == 0 && ring->start[1] == PBW__GHOST && !kernel->weighted) {
        status = pbw__ring_start_hull(kernel, ring, &point, &head);
    }
    return status == PBW_OK ? pbw__ring_finish(kernel, ring, head, &point, 1) : status;
}

/* Tests the first three edges together with the six that would replace them, as waiting for the first verdicts costs
   more.  Sets *head to the number of edges of the queue that are done; it stays 0 at the hull, and where a verdict
   stays open.  Only without weights.  A triangle that is looked at and not deleted has a vertex of the first one,
   which is ours: (a) and (b) of >>parallel hold for it. */
PBW__SIMD_INLINE pbw_status pbw__ring_start(pbw__kernel *kernel, pbw__ring *ring, const pbw__link *beyond,
                                            const pbw__triangles *t, const pbw__point4 *point, unsigned *head)
{
    const pbw_index *corner = kernel->corner;
    const pbw__link *link = kernel->link;
    const pbw_index a0 = corner[link[PBW__AFTER(beyond[0])]], a1 = corner[link[PBW__AFTER(beyond[1])]],
                    a2 = corner[link[PBW__AFTER(beyond[2])]], b0 = corner[link[PBW__BEFORE(beyond[0])]],
                    b1 = corner[link[PBW__BEFORE(beyond[1])]], b2 = corner[link[PBW__BEFORE(beyond[2])]];
    const pbw_index a[4] = { a0, a1, a2, a0 }, b[4] = { b0, b1, b2, b0 };
    pbw__triangles after, before;
    unsigned certain[3], inside[3];
    pbw_status status;
    after.s = t->s, after.e = t->o, after.o = pbw__rows4_of(kernel->record, a, 0, point);
    before.s = t->o, before.e = t->e, before.o = pbw__rows4_of(kernel->record, b, 0, point);
    inside[0] = pbw__test2_simd(t, 0, &certain[0]) & 7;
    inside[1] = pbw__test2_simd(&after, 0, &certain[1]);
    inside[2] = pbw__test2_simd(&before, 0, &certain[2]);
    if (PBW__UNLIKELY(a0 == PBW__GHOST || a1 == PBW__GHOST || a2 == PBW__GHOST || b0 == PBW__GHOST || b1 == PBW__GHOST
                      || b2 == PBW__GHOST)) {
        return PBW_OK;
    }
    if (PBW__UNLIKELY((certain[0] & certain[1] & certain[2]) != 15)) {
        PBW__PHASE(PBW__EXACT);
        certain[0] |= pbw__settle2(kernel, t, 7 & ~certain[0], &inside[0]);
        certain[1] |= pbw__settle2(kernel, &after, inside[0] & ~certain[1], &inside[1]);
        certain[2] |= pbw__settle2(kernel, &before, inside[0] & ~certain[2], &inside[2]);
        PBW__PHASE(PBW__CAVITY);
        if ((certain[0] & 7) != 7 || (inside[0] & ~(certain[1] & certain[2])) != 0) {
            return PBW_OK;
        }
    }
    status = pbw__ring_split(kernel, ring, 0, inside[0], 0);
    *head = ring->tail;
    return status != PBW_OK ? status                 /* those in the queue */
                            : pbw__ring_split(kernel, ring, 3, pbw__pairs_of(inside[1], inside[2], inside[0]), 0);
}

/* Finds the cavity of the point from t, a triangle in conflict, of these rows if it is finite.
   PBW__RING_OVERFLOW: the cavity does not fit the ring, or a vertex may become hidden. */
PBW__SIMD_INLINE pbw_status pbw__carve2_simd(pbw__kernel *kernel, pbw__ring *ring, pbw_index t,
                                             const pbw__rows4 *rows, const pbw__point4 *point)
{
    static const unsigned next[3] = { 1, 2, 0 };
    const pbw_index *corner = kernel->corner, *v = corner + 4 * (size_t)t;
    const pbw__link *link = kernel->link + 4 * (size_t)t;
    const pbw__link beyond[3] = { link[0], link[1], link[2] };
    const pbw_index far[4] = { corner[beyond[0]], corner[beyond[1]], corner[beyond[2]], corner[beyond[0]] };
    pbw__triangles first;
    pbw_status status = PBW_OK;
    unsigned head = 0;
    memcpy(ring->start, v + 1, 2 * sizeof(*v));
    ring->start[2] = v[0];
    memcpy(ring->beyond, link, 3 * sizeof(*link));
    memcpy(ring->next, next, sizeof(next));
    memcpy(ring->queue, "\0\1\2", 4);
    ring->slot[0] = t;
    ring->count = ring->tail = 3;
    ring->hull = 0;
    if (PBW__UNLIKELY(v[2] == PBW__GHOST || far[0] == PBW__GHOST || far[1] == PBW__GHOST || far[2] == PBW__GHOST)) {
        return pbw__ring_hull(kernel, ring, 0, point->p);
    }
    first.o = pbw__rows4_of(kernel->record, far, 0, point);
    PBW__CORNERS2(first.s, *rows, PBW__EDGE_START);
    PBW__CORNERS2(first.e, *rows, PBW__EDGE_END);
    if (!point->weighted) {
        status = pbw__ring_start(kernel, ring, beyond, &first, point, &head);
    }
    if (PBW__UNLIKELY(head == 0)) {
        status = pbw__ring_step(kernel, ring, 0, &first, point, 0);
        head = 3;
    }
    return status == PBW_OK ? pbw__ring_finish(kernel, ring, head, point, 0) : status;
}

/* Turns the triangle (vertex, ghost, end) of a new star, if there is one, to (end, vertex, ghost).  The next walk
   then starts there: others of the star may be long and thin. */
static PBW__NOINLINE void pbw__turn_ghost(pbw__kernel *kernel, const pbw__ring *ring)
{
    pbw_index *corner = kernel->corner;
    pbw__link *link = kernel->link, base, last;
    unsigned i;
    for (i = 0; i < ring->count && ring->start[i] != PBW__GHOST; i++) {
    }
    if (i == ring->count) {
        return;
    }
    kernel->last = ring->slot[i];
    base = (pbw__link)kernel->last << 2;
    last = link[base + 2];
    corner[base + 1] = corner[base];
    corner[base] = corner[base + 2];
    corner[base + 2] = PBW__GHOST;
    link[base + 2] = link[base + 1];
    link[base + 1] = link[base];
    link[base] = last;
    link[link[base]] = base;
    link[link[base + 1]] = base | 1;
    link[link[base + 2]] = base | 2;
}

/* Writes the star into the slots of the cavity and two more; pbw__refill2 explains the numbers of the corners.  The
   next walk starts in the triangle towards the next vertex, which is guessed: as far along the curve from this vertex
   as this one is from the last. */
PBW__SIMD_INLINE void pbw__refill2_simd(pbw__kernel *kernel, pbw__ring *ring, pbw_index vertex, size_t width)
{
    pbw_index *corner = kernel->corner;
    pbw__link *link = kernel->link;
    const double *record = kernel->record;
    unsigned count = ring->count, i;
    const pbw_index next = 2 * vertex - kernel->previous, guess = next <= kernel->vertex_count ? next : vertex;
    const pbw__d2 p = pbw__load2(record + width * vertex);
    const pbw__d2 normal = pbw__turn_right(pbw__load2(record + width * guess) - p);
    pbw_index last = ring->slot[0];
    kernel->previous = vertex;
    ring->slot[count - 2] = (pbw_index)kernel->slots.fresh;
    ring->slot[count - 1] = (pbw_index)kernel->slots.fresh + 1;
    kernel->slots.fresh += 2;
    kernel->statistics.created += count;
    kernel->statistics.conflict_tests += ring->tail;
    for (i = 0; i < count; i++) {
        const unsigned n = ring->next[i];
        const size_t base = 4 * (size_t)ring->slot[i], after = 4 * (size_t)ring->slot[n];
        const pbw_index start = ring->start[i], end = ring->start[n];
        corner[base] = vertex;
        corner[base + 1] = start;
        corner[base + 2] = end;
        link[base] = ring->beyond[i];
        link[base + 1] = (pbw__link)after + 2;
        link[after + 2] = (pbw__link)base + 1;
        link[ring->beyond[i]] = (pbw__link)base;
        if (PBW__LIKELY(!ring->hull)) {
            const pbw__d2 from = pbw__load2(record + width * start) - p, to = pbw__load2(record + width * end) - p;
            last = pbw__signs2(from * normal, to * normal) == 2 ? ring->slot[i] : last;
        }
    }
    kernel->last = last;
    if (PBW__UNLIKELY(ring->hull)) {
        pbw__turn_ghost(kernel, ring);
    }
    if (PBW__UNLIKELY(kernel->own.owner != NULL)) {      /* >>parallel looks for hints there */
        memcpy(kernel->scratch.cavity, ring->slot, sizeof(ring->slot));      /* a constant size is faster */
        kernel->scratch.facet_count = count;
    }
}
#endif
/* ------------------------------------------------------------------------------------------------------
   >>build        All vertices into one triangulation.
   In: vertices along the Hilbert curve.  Out: the store with their triangulation, or PBW_DEGENERATE.

   Insertion order: level l holds the ranks divisible by 8^l (2D: 64^l) that no higher level holds; levels go from
   coarse to fine, along the curve, alternately forwards and backwards.
     1. Coarse levels keep the cavities small, as the random rounds of Amenta, Choi & Rote 2003 ("Incremental
        constructions con BRIO") do, but need no shuffle and no second sort.
     2. Within a level the next point lies near the last one, so the walk is short and the caches warm.
     3. The finest level goes backwards.  So a vertex has the lowest rank of its neighbourhood when it is inserted,
        and most simplices that will belong to it in >>number are made with its star, in slots side by side.
     4. Fewer levels are faster on one thread (each coarse step is a cache miss) until cavities grow.  In space, where
        they grow on lattices and tasks contend for zones, a ratio of 8 is better.

   Where points lie near a few lines, only the outermost vertices of a line have neighbours on other lines, and their
   stars are large.  Each level would make such stars and destroy them again, as vertices farther out come.  So in
   space, once the stars of a level are large, the extremes come next: of each span of ranks the vertices farthest
   from the line along it, on eight sides across that line.  Most other vertices then have near neighbours only, and
   one of the two finest levels is left out.  (Of a million points on 8 lines 28,000 have neighbours on other lines;
   13,000 are extremes.)
   ------------------------------------------------------------------------------------------------------ */
/* Replaces the cavity of a vertex at p, which contains t, by its star. */
static PBW__NOINLINE pbw_status pbw__replace(pbw__kernel *kernel, pbw_index t, pbw_index vertex, const double *p)
{
    const int dim = kernel->dim;
    pbw_status status;
    PBW__PHASE(PBW__CAVITY);
    status = dim == 3 ? pbw__carve3_scalar(kernel, t, p) : pbw__carve2(kernel, t, p);
    PBW__PHASE(PBW__STAR);
    status = status == PBW_OK ? pbw__take_slots(kernel) : status;
    return status != PBW_OK ? status : dim == 3 ? pbw__refill3(kernel, vertex) : pbw__refill2(kernel, vertex);
}

/* Inserts a vertex, which may turn out to be hidden.  PBW__DEFERRED: another task owns a zone that this one needs. */
static pbw_status pbw__insert_scalar(pbw__kernel *kernel, pbw_index vertex)
{
    pbw_index t = pbw__insert_start(kernel, vertex);
    pbw_status status;
    double p[4];
    pbw__copy_record(pbw__record_at(kernel, vertex), p, kernel->dim, kernel->weighted);
    PBW__PHASE(PBW__WALK);
    if (t != PBW__FOREIGN) {
        t = PBW__BY_DIM(kernel->dim, pbw__locate_of, kernel, t, p);
    }
    status = pbw__located(kernel, t);
    if (t == PBW_NONE || status != PBW_OK) {
        return status;                               /* hidden, or not ours */
    }
    status = pbw__replace(kernel, t, vertex, p);
    PBW__PHASE(PBW__OTHER);
    return status;
}

#ifdef PBW__SIMD
/* Prefetches for the insertion four vertices on: at coarse levels each vertex has cache lines of its own. */
PBW__INLINE void pbw__ask_ahead2(const pbw__kernel *kernel, pbw_index vertex)
{
    const size_t fresh = kernel->slots.fresh, slot = fresh + 8 < kernel->slots.fresh_end ? fresh + 8 : fresh;
    const pbw_index later = vertex + 4 * (vertex - kernel->previous);
    PBW__PREFETCH_TO_WRITE(kernel->corner + 4 * slot);
    PBW__PREFETCH_TO_WRITE(kernel->link + 4 * slot);
    PBW__PREFETCH(pbw__record_at(kernel, later <= kernel->vertex_count ? later : vertex));
}

/* Insertion with vectors; dim, weighted and the width of records are constants. */
PBW__SIMD_INLINE pbw_status pbw__insert_simd(pbw__kernel *kernel, pbw_index vertex, int dim, int weighted,
                                             size_t width)
{
    const pbw__d4 zero = pbw__splat(0.0);
    pbw__rows4 rows = { zero, zero, zero, zero, zero, zero };
    pbw_index t = pbw__insert_start(kernel, vertex);
    pbw__point4 point;
    pbw__ring ring;
    pbw_status status;
    double p[4];
    if (dim == 2) {
        pbw__ask_ahead2(kernel, vertex);
    }
    pbw__copy_record(kernel->record + width * vertex, p, dim, weighted);
    point = pbw__point4_of(p, dim, weighted, width);
    PBW__PHASE(PBW__WALK);
    if (PBW__LIKELY(t != PBW__FOREIGN)) {
        t = dim == 3 ? pbw__locate3_simd(kernel, t, &point) : pbw__locate2_simd(kernel, t, &point, &rows);
    }
    status = pbw__located(kernel, t);
    if (PBW__UNLIKELY(t == PBW_NONE) || PBW__UNLIKELY(status != PBW_OK)) {
        return status;                               /* hidden, or not ours */
    }
    PBW__PHASE(PBW__CAVITY);
    if (dim == 3) {
        status = pbw__carve3_simd(kernel, t, &point);
        PBW__PHASE(PBW__STAR);
        status = PBW__LIKELY(status == PBW_OK) ? pbw__take_slots(kernel) : status;
        status = PBW__LIKELY(status == PBW_OK) ? pbw__refill3_simd(kernel, vertex) : status;
    } else {
        status = PBW__LIKELY(kernel->slots.fresh_end - kernel->slots.fresh >= 2)
               ? pbw__carve2_simd(kernel, &ring, t, &rows, &point) : PBW__RING_OVERFLOW;
        PBW__PHASE(PBW__STAR);
        if (PBW__LIKELY(status == PBW_OK)) {
            pbw__refill2_simd(kernel, &ring, vertex, width);
        } else if (status == PBW__RING_OVERFLOW) {
            status = pbw__replace(kernel, t, vertex, p);
        }
    }
    PBW__PHASE(PBW__OTHER);
    return status;
}

#define PBW__INSERT_SIMD(name, dim, weighted, width) \
    PBW__SIMD static pbw_status name(pbw__kernel *kernel, pbw_index vertex) \
    { \
        return pbw__insert_simd(kernel, vertex, dim, weighted, width); \
    }
PBW__INSERT_SIMD(pbw__insert2_simd, 2, 0, 2)
PBW__INSERT_SIMD(pbw__insert2_padded_simd, 2, 0, 3)
PBW__INSERT_SIMD(pbw__insert2_weighted_simd, 2, 1, 3)
PBW__INSERT_SIMD(pbw__insert3_simd, 3, 0, 3)
PBW__INSERT_SIMD(pbw__insert3_padded_simd, 3, 0, 4)
PBW__INSERT_SIMD(pbw__insert3_weighted_simd, 3, 1, 4)
#endif

/* The memory of insertions; context and dim are set. */
static pbw_status pbw__scratch_create(pbw__kernel *kernel)
{
    if (!pbw__grow_lists(kernel, 64)) {
        return PBW_ERROR_MEMORY;
    }
    if (kernel->dim == 2) {
        return PBW_OK;
    }
    kernel->scratch.table = (uint64_t *)pbw__allocate(&kernel->context->memory, PBW__TABLE, sizeof(uint64_t));
    if (kernel->scratch.table == NULL || !PBW__GROW(kernel, &kernel->scratch, edge, PBW__FEW * PBW__FEW)) {
        return PBW_ERROR_MEMORY;
    }
    memset(kernel->scratch.table, 0, PBW__TABLE * sizeof(uint64_t));
    return PBW_OK;
}

/* Makes a kernel for one thread; on failure the caller must still free it. */
static pbw_status pbw__kernel_create(pbw__kernel *kernel, pbw__context *context, pbw__store *store,
                                     const pbw__vertices *vertices, const pbw__grid *grid)
{
    const int dim = vertices->dim;
#ifdef PBW__SIMD
    pbw_status (*const insert[2][3])(pbw__kernel *, pbw_index) = {
        { pbw__insert2_simd, pbw__insert2_padded_simd, pbw__insert2_weighted_simd },
        { pbw__insert3_simd, pbw__insert3_padded_simd, pbw__insert3_weighted_simd }
    };
#endif
    memset(kernel, 0, offsetof(pbw__kernel, own));
    memset(&kernel->own, 0, offsetof(pbw__ownership, claim));
    kernel->context = context;
    kernel->store = store;
    kernel->record = vertices->record;
    kernel->width = vertices->width;
    kernel->vertex_count = (pbw_index)vertices->count;
    kernel->grid = grid;
    kernel->dim = dim;
    kernel->weighted = vertices->weighted;
    /* Within 2^+-100 no power up to the tenth of a unit underflows or overflows. */
    kernel->exact_height = grid->inverse_unit > 1e-30 && grid->inverse_unit < 1e30
                         ? (dim == 3 ? PBW__EXACT_HEIGHT3 : PBW__EXACT_HEIGHT2)
                           / (grid->inverse_unit * grid->inverse_unit) : 0.0;
    kernel->slots.region = (size_t)-1;
    kernel->last = PBW_NONE;
    kernel->insert = pbw__insert_scalar;
#ifdef PBW__SIMD
    if (pbw__simd_works()) {
        kernel->insert = insert[dim == 3][kernel->weighted ? 2 : kernel->width > (size_t)dim];
    }
#endif
    pbw__kernel_attach(kernel);
    return pbw__scratch_create(kernel);
}

/* A level of the insertion order: of `count` ranks those that `stride` divides and `coarser` does not; in the
   coarsest level, where coarser > count, all that stride divides.  Both are powers of two. */
typedef struct pbw__level { size_t count, stride, coarser; int backwards; } pbw__level;

/* Returns the coarsest level. */
static pbw__level pbw__level_first(size_t count, int dim)
{
    const size_t ratio = dim == 3 ? 8 : 64;
    pbw__level level;
    level.count = count;
    level.backwards = 1;                             /* the finest */
    for (level.stride = 1; count / level.stride >= ratio; level.stride *= ratio) {
        level.backwards = !level.backwards;
    }
    level.coarser = level.stride * ratio;
    return level;
}

/* Goes on to the level of this stride; 0: there are no more levels. */
static void pbw__level_next(pbw__level *level, size_t stride)
{
    level->coarser = level->stride;
    level->stride = stride;
    level->backwards = stride == 1 || !level->backwards;
}

/* Returns the number of ranks of a level. */
PBW__INLINE size_t pbw__level_size(const pbw__level *level)
{
    const size_t last = level->count - 1;            /* rank 0 is the coarsest level's */
    return level->coarser > level->count ? last / level->stride + 1 : last / level->stride - last / level->coarser;
}

/* Return the i-th rank of a level in the order of insertion, and the one that follows a rank. */
PBW__INLINE size_t pbw__level_rank(const pbw__level *level, size_t i)
{
    const size_t at = level->backwards ? pbw__level_size(level) - 1 - i : i;
    return (level->coarser > level->count ? at : at + at / (level->coarser / level->stride - 1) + 1) * level->stride;
}

PBW__INLINE size_t pbw__level_after(const pbw__level *level, size_t rank)
{
    const size_t step = level->backwards ? 0 - level->stride : level->stride;
    rank += step;
    return (rank & (level->coarser - 1)) == 0 && level->coarser <= level->count ? rank + step : rank;
}

/* Finds the first dim+1 vertices of the order that span the space, positively oriented.  Vertices are at different
   places, so any two will do.  Linear: once a vertex is passed over, it lies in the span of the seeds. */
static pbw_status pbw__seeds(pbw__kernel *kernel, size_t count, int dim, pbw_index *seed)
{
    pbw__level level = pbw__level_first(count, dim);
    const size_t ratio = level.coarser / level.stride;
    const double *x[4];
    int found = 0;
    for (; level.stride > 0; pbw__level_next(&level, level.stride / ratio)) {
        const size_t size = pbw__level_size(&level);
        size_t i, rank = pbw__level_rank(&level, 0);
        for (i = 0; i < size; i++, rank = pbw__level_after(&level, rank)) {
            int side;
            x[found] = pbw__record_at(kernel, (pbw_index)rank + 1);
            side = found == dim ? pbw__orient(dim, x, kernel->grid)      /* 0: in the span of the seeds before */
                                : found != 2 || !pbw__collinear3(x[0], x[1], x[2], kernel->grid);
            if ((i & 255) == 255 && pbw__report(kernel->context, 0.001)) {
                return PBW_CANCELLED;
            }
            if (side == 0) {
                continue;
            }
            seed[found++] = (pbw_index)rank + 1;
            if (found == dim + 1) {
                if (side < 0) {
                    pbw_index swap = seed[0];
                    seed[0] = seed[1];
                    seed[1] = swap;
                }
                return PBW_OK;
            }
        }
    }
    return PBW_DEGENERATE;
}

/* Makes the simplex of the seeds and a ghost on each of its facets: that across from seed i has the others,
   seed[of[i][k]] in corner k, where seed j is in corner at[i][j]. */
static pbw_status pbw__first_star(pbw__kernel *kernel, int dim, const pbw_index *seed)
{
    pbw_index slot[5] = { 0, 0, 0, 0, 0 };
    const unsigned last = (unsigned)dim;
    unsigned of[4][3], at[4][4], i, k;
    pbw__link inside;
    for (i = 0; i <= last; i++) {
        for (k = 0; k < last; k++) {                 /* outside positive */
            of[i][k] = dim == 3 ? pbw__facet_corners[i][k + 1] : (i + 2 - k) % 3;
            at[i][of[i][k]] = k;
        }
    }
    pbw__enter_region(kernel, seed[0] >> kernel->store->region_bits);
    if (kernel->slots.fresh_end - kernel->slots.fresh < (size_t)dim + 2) {
        pbw_status status = pbw__more_tail(kernel, (size_t)dim + 2);
        if (status != PBW_OK) {
            return status;
        }
    }
    for (i = 0; i <= last + 1; i++) {
        slot[i] = pbw__take_slot(kernel);
    }
    inside = (pbw__link)slot[0] * 4;
    for (i = 0; i <= last; i++) {
        const pbw__link ghost = (pbw__link)slot[i + 1] * 4;
        kernel->corner[inside + i] = seed[i];
        kernel->link[inside + i] = ghost | last;
        kernel->corner[ghost + last] = PBW__GHOST;
        kernel->link[ghost + last] = inside | i;
        for (k = 0; k < last; k++) {                 /* across from seed j: the ghost across from it, at seed i */
            const unsigned j = of[i][k];
            kernel->corner[ghost + k] = seed[j];
            kernel->link[ghost + k] = (pbw__link)slot[j + 1] * 4 | at[j][i];
        }
    }
    kernel->last = slot[0];
    return PBW_OK;
}

#define PBW__TASKS 255
#define PBW__LEAST_TASK ((size_t)PBW__SMALLER(512))  /* vertices for each task, below which they are too near */
#define PBW__HOLD ((size_t)PBW__SMALLER(256))        /* zones that a task holds from vertex to vertex, at most, */
#define PBW__HOLDS 8                                 /* or one in 8 of its share: others have to get by */
#define PBW__BATCH ((size_t)PBW__SMALLER(64))        /* vertices that a task comes to at a time, at least, */
#define PBW__BATCHES 32                              /* or a 32nd of its share */
#define PBW__LEAST_SHARE 32                          /* vertices left for each task, or there are fewer tasks */
#define PBW__LARGE_STAR 36                           /* simplices for a vertex; terrain makes 31, lines 42 and more */
#define PBW__SPAN 512                                /* ranks with extremes of their own */
#define PBW__FIRST 8                                 /* one extreme in 8 is inserted first, on one thread */

typedef struct pbw__build {
    pbw__context *context;
    pbw__store *store;
    const pbw__vertices *vertices;
    const pbw__grid *grid;
    pbw__kernel *kernel[PBW__TASKS];                 /* one for each task */
    pbw_statistics *statistics;
    uint32_t trace;                                  /* 256 * the round */
    int kernel_count, tasks;
    uint8_t *owner;                                  /* per zone */
    uint32_t taken[PBW__TASKS];                      /* per share of the vertices: batches taken from its front, and
                                                        65536 times those from its end */
    size_t count;                                    /* vertices of the round */
    pbw__level level;
    unsigned char *early;                            /* a bit for each rank: an extreme, which comes before its level;
                                                        NULL: no vertex does */
    int hold;                                        /* zones that a task holds, at most */
    int owner_bits, hint_bits;                       /* of the level's zones, of the last level's that had hints */
    pbw_index seed[4];
    pbw_index *left;                                 /* vertices left */
    size_t left_count, left_capacity;
    size_t done;
} pbw__build;

/* Insertion by several threads: >>parallel. */
static pbw_status pbw__insert_claiming(pbw__build *build, pbw__kernel *kernel, pbw_index v);
static pbw_status pbw__rounds(pbw__build *build);

/* Returns the first region of a zone.  A zone has several where few vertices of a region are inserted yet. */
PBW__INLINE size_t pbw__first_region(const pbw__build *build, size_t zone)
{
    size_t region = zone << (build->owner_bits - build->store->region_bits);
    return region < build->store->region_count ? region : build->store->region_count;
}

/* Sets kernel->last to the start of the walk to a vertex: the end of the last walk, unless that is far and a zone
   nearby has a hint.  A task must own the zone of the hint or claim it.  From far away a walk would claim every zone
   on its way, and among points on a line it would visit all of them.  Returns 0 if there is no start. */
static int pbw__find_start(pbw__build *build, pbw__kernel *kernel, pbw_index v)
{
    pbw__store *store = build->store;
    const size_t zone = v >> build->owner_bits;
    const size_t from = kernel->slots.region << store->region_bits >> build->owner_bits;     /* far off, if none */
    const pbw_index last = kernel->last;
    size_t k;
    kernel->last = from - zone + 1 <= 2 ? last : PBW_NONE;
    for (k = 0; k < 16 && kernel->last == PBW_NONE; k++) {
        size_t near = (k & 1) != 0 ? zone + (k + 1) / 2 : zone - k / 2, region = pbw__first_region(build, near);
        if (near <= build->vertices->count >> build->owner_bits && PBW__LOAD(store->hint + region) != PBW_NONE
            && (kernel->own.owner == NULL || pbw__owns_zone(kernel, near))) {
            pbw_index hint = store->hint[region];
            kernel->last = hint != PBW_NONE && kernel->corner[4 * (size_t)hint] != PBW_NONE ? hint : PBW_NONE;
        }
    }
    kernel->last = kernel->last != PBW_NONE ? kernel->last : last;
    return kernel->last != PBW_NONE;
}

/* Inserts a vertex, or leaves it for later.  Returns 0 to stop. */
PBW__INLINE int pbw__level_insert(pbw__build *build, pbw__kernel *kernel, pbw_index v)
{
    const int alone = kernel->own.owner == NULL;
    size_t work;
    pbw_status status;
    if (v == build->seed[0] || v == build->seed[1] || v == build->seed[2] || v == build->seed[3]) {
        return 1;
    }
    /* Once a star finds no room, the rest of the round would search cavities in vain: leave the vertices. */
    status = alone ? kernel->insert(kernel, v)
           : kernel->slots.no_room ? PBW__DEFERRED : pbw__insert_claiming(build, kernel, v);
    if (status == PBW__DEFERRED) {
        if (!PBW__GROW(kernel, kernel, left, kernel->left_count + 1)) {
            kernel->status = PBW_ERROR_MEMORY;
            return 0;
        }
        kernel->left[kernel->left_count++] = v;
        PBW__TEST_PAUSE();
    } else if (status != PBW_OK) {
        kernel->status = status;
        return 0;
    }
    if (build->context->options.trace != NULL) {
        build->context->options.trace[build->vertices->id[v]] = build->trace | (alone ? 0u : kernel->own.share);
    }
    kernel->done += status == PBW_OK;
    /* An exact test of extreme exponents may take 0.2 ms, a new simplex takes 0.1 us. */
    work = kernel->statistics.created + kernel->statistics.walk_steps + 64 * kernel->statistics.exact_tests;
    if (work - kernel->reported > 4096) {
        double done = (double)build->done + (double)kernel->done * (double)(alone ? 1 : build->tasks);
        kernel->reported = work;
        done /= (double)build->vertices->count;      /* a guess: other tasks may be slower */
        if (pbw__report(build->context, done < 0.999 ? done : 0.999)) {
            kernel->status = PBW_CANCELLED;
            return 0;
        }
    }
    return 1;
}

/* Returns whether a vertex comes before its level. */
PBW__INLINE int pbw__is_early(const pbw__build *build, size_t rank)
{
    return PBW__UNLIKELY(build->early != NULL) && (build->early[rank >> 3] >> (rank & 7) & 1) != 0;
}

/* Inserts all vertices of the level: along the curve, or back. */
static void pbw__insert_level(pbw__build *build, pbw__kernel *kernel)
{
    const pbw__level level = build->level;
    size_t rank = pbw__level_rank(&level, 0), left = pbw__level_size(&level);
    for (; left > 0; left--, rank = pbw__level_after(&level, rank)) {
        if (!pbw__is_early(build, rank) && !pbw__level_insert(build, kernel, (pbw_index)rank + 1)) {
            return;
        }
    }
}

/* Inserts the vertices left, or the whole level, on one thread. */
static pbw_status pbw__level_serial(pbw__build *build, int all)
{
    pbw__kernel *kernel = build->kernel[0];
    const pbw__store *store = build->store;
    const pbw_index *corner = store->corner;
    size_t i, r;
    pbw__kernel_attach(kernel);
    kernel->own.owner = NULL;
    kernel->status = PBW_OK;
    /* Any simplex serves as a start, best the last one.  The used slots of the regions always hold one: the simplices
       of the seeds, or those that replaced them, unless all regions are full. */
    kernel->last = kernel->last != PBW_NONE && corner[4 * (size_t)kernel->last] != PBW_NONE ? kernel->last : PBW_NONE;
    for (r = 0; r <= store->region_count && kernel->last == PBW_NONE; r++) {
        size_t end = r < store->region_count ? store->region[r] : store->count;
        i = r < store->region_count ? r > 0 ? pbw__region_end(store, r - 1) : 0 : store->region_slots;
        for (; i < end && kernel->last == PBW_NONE; i++) {
            kernel->last = corner[4 * i] != PBW_NONE ? (pbw_index)i : PBW_NONE;
        }
    }
    if (all) {
        pbw__insert_level(build, kernel);
    }
    for (i = 0; !all && i < build->left_count && pbw__find_start(build, kernel, build->left[i])
                && pbw__level_insert(build, kernel, build->left[i]); i++) {
    }
    pbw__leave_region(kernel);
    build->done += kernel->done;
    build->statistics->serial += kernel->done;
    build->trace += kernel->done > 0 ? 256 : 0;
    kernel->done = 0;
    return kernel->status;
}

/* Makes kernels for `count` tasks. */
static pbw_status pbw__more_kernels(pbw__build *build, int count)
{
    while (build->kernel_count < count) {
        pbw__kernel *kernel = (pbw__kernel *)pbw__allocate(&build->context->memory, 1, sizeof(pbw__kernel));
        if (kernel == NULL) {
            return PBW_ERROR_MEMORY;
        }
        build->kernel[build->kernel_count++] = kernel;
        if (pbw__kernel_create(kernel, build->context, build->store, build->vertices, build->grid) != PBW_OK) {
            return PBW_ERROR_MEMORY;
        }
    }
    return PBW_OK;
}

/* Plans the tasks for a number of vertices, and the size of zones: each has room for two (in 2D one) of the vertices
   inserted so far, which are `apart` ranks from each other. */
static void pbw__plan(pbw__build *build, size_t vertices, size_t apart)
{
    size_t tasks = vertices / PBW__LEAST_TASK, zones;
    for (build->owner_bits = build->store->region_bits;
         (size_t)1 << build->owner_bits < apart * (size_t)(build->vertices->dim - 1); build->owner_bits++) {
    }
    zones = (build->vertices->count >> build->owner_bits) + 1;
    tasks = tasks < zones / PBW__SMALLER(4) ? tasks : zones / PBW__SMALLER(4);
    build->tasks = (size_t)build->context->threads < tasks ? build->context->threads : (int)tasks;
}

/* Inserts the level, or the vertices left, by the tasks planned. */
static pbw_status pbw__run_level(pbw__build *build)
{
    const int all = build->tasks <= 1 && build->left_count == 0;
    const pbw_status status = build->tasks > 1 ? pbw__rounds(build) : PBW_OK;
    return status == PBW_OK ? pbw__level_serial(build, all) : status;
}

/* Finds the line that fits a span of vertices best: the slopes of the two coordinates after its longest axis.
   Returns the axis. */
static int pbw__line_along(const double *record, size_t width, size_t count, double slope[2])
{
    double sum[3] = { 0, 0, 0 }, square[3] = { 0, 0, 0 }, product[3] = { 0, 0, 0 };      /* of k and k + 1 */
    const double *p = record;
    size_t i;
    int k, axis = 0;
    for (i = 0; i < count; i++, p += width) {
        const double x = p[0] - record[0], y = p[1] - record[1], z = p[2] - record[2];
        sum[0] += x, sum[1] += y, sum[2] += z;
        square[0] += x * x, square[1] += y * y, square[2] += z * z;
        product[0] += x * y, product[1] += y * z, product[2] += z * x;
    }
    for (k = 0; k < 3; k++) {
        square[k] -= sum[k] * sum[k] / (double)count;
        product[k] -= sum[k] * sum[(k + 1) % 3] / (double)count;
        axis = square[k] > square[axis] ? k : axis;
    }
    slope[0] = square[axis] > 0.0 ? product[axis] / square[axis] : 0.0;
    slope[1] = square[axis] > 0.0 ? product[(axis + 2) % 3] / square[axis] : 0.0;
    return axis;
}

/* Marks the extremes of some spans that are not inserted yet: the farthest from the line on eight sides. */
static pbw_status pbw__find_extremes(void *arg, size_t span, size_t to)
{
    pbw__build *build = (pbw__build *)arg;
    const size_t count = build->vertices->count, width = build->vertices->width;
    for (; span < to; span++) {
        const size_t begin = span * PBW__SPAN, end = begin + PBW__SPAN < count ? begin + PBW__SPAN : count;
        const double *first = build->vertices->record + width * (begin + 1), *p = first;
        double slope[2], farthest[8];
        const int axis = pbw__line_along(first, width, end - begin, slope);
        const int next = (axis + 1) % 3, last = (axis + 2) % 3;
        size_t rank, extreme[8];
        int k;
        for (k = 0; k < 8; k++) {
            farthest[k] = 0.0;                       /* as the first has it, on all sides */
            extreme[k] = begin;
        }
        for (rank = begin; rank < end; rank++, p += width) {
            const double along = p[axis] - first[axis];
            const double u = p[next] - first[next] - slope[0] * along, v = p[last] - first[last] - slope[1] * along;
            const double off[8] = { u, v, u + v, u - v, -u, -v, -u - v, v - u };
            for (k = 0; k < 8; k++) {
                extreme[k] = off[k] > farthest[k] ? rank : extreme[k];
                farthest[k] = off[k] > farthest[k] ? off[k] : farthest[k];
            }
        }
        memset(build->early + begin / 8, 0, (end - begin + 7) / 8);
        for (k = 0; k < 8; k++) {
            rank = extreme[k];
            build->early[rank >> 3] |= (unsigned char)(((rank & (build->level.stride - 1)) != 0) << (rank & 7));
        }
    }
    return PBW_OK;
}

/* Inserts the extremes: first one in eight, on one thread, as the first stars reach so many zones that tasks would
   contend for them; then the others, by few tasks. */
static pbw_status pbw__level_extremes(pbw__build *build)
{
    pbw_memory *memory = &build->context->memory;
    const size_t count = build->vertices->count, most = 8 * (count / PBW__SPAN + 1);
    size_t rank, seen, first;
    pbw_status status;
    int turn;
    build->early = (unsigned char *)pbw__allocate(memory, count / 8 + 1, 1);
    if (build->early == NULL) {
        return PBW_ERROR_MEMORY;
    }
    status = pbw__for_range(build->context, (count + PBW__SPAN - 1) / PBW__SPAN, 16, 0.0, pbw__find_extremes, build);
    if (status == PBW_OK && most > build->left_capacity && !PBW__RESIZE(memory, build, left, most)) {
        status = PBW_ERROR_MEMORY;
    }
    pbw__plan(build, most, 0);
    first = build->tasks > 1 ? PBW__FIRST : 1;
    for (turn = 0; turn < 2 && status == PBW_OK; turn++) {
        for (rank = seen = build->left_count = 0; rank < count; rank += build->early[rank >> 3] != 0 ? 1 : 8) {
            if (pbw__is_early(build, rank) && (seen++ % first != 0) == turn) {
                build->left[build->left_count++] = (pbw_index)rank + 1;
            }
        }
        if (build->left_count > 0) {
            pbw__plan(build, turn > 0 ? build->left_count / 4 : 0, 0);
            status = pbw__run_level(build);
        }
    }
    return status;
}

/* Returns PBW_OK, PBW_DEGENERATE or an error; the caller frees the store in every case. */
static pbw_status pbw__build_all(pbw__context *context, pbw__store *store, const pbw__vertices *vertices,
                                 const pbw__grid *grid, pbw_statistics *statistics)
{
    pbw_memory *memory = &context->memory;
    pbw__build build;
    size_t ratio, stride, before, created = 0;       /* simplices made before a level, and after it */
    pbw_status status;
    int i;
    memset(&build, 0, sizeof(build));
    build.context = context;
    build.store = store;
    build.vertices = vertices;
    build.grid = grid;
    build.statistics = statistics;
    status = pbw__store_create(context, store, vertices->count, vertices->dim);
    status = status == PBW_OK ? pbw__more_kernels(&build, 1) : status;
    status = status == PBW_OK ? pbw__seeds(build.kernel[0], vertices->count, vertices->dim, build.seed) : status;
    status = status == PBW_OK ? pbw__first_star(build.kernel[0], vertices->dim, build.seed) : status;
    for (i = 0; status == PBW_OK && context->options.trace != NULL && i <= vertices->dim; i++) {
        context->options.trace[vertices->id[build.seed[i]]] = 0;
    }
    build.level = pbw__level_first(vertices->count, vertices->dim);
    ratio = build.level.coarser / build.level.stride;
    while (status == PBW_OK && build.level.stride > 0) {
        stride = build.level.stride;
        pbw__plan(&build, vertices->count / stride, build.early != NULL ? 0 : build.level.coarser);
        build.tasks = build.level.coarser <= vertices->count ? build.tasks : 1;
        build.left_count = 0;
        status = pbw__run_level(&build);
        for (i = 0, before = created, created = 0; i < build.kernel_count; i++) {
            created += build.kernel[i]->statistics.created;
        }
        if (created - before > PBW__LARGE_STAR * (pbw__level_size(&build.level) + 1) && vertices->dim == 3
            && stride > 1 && build.early == NULL && status == PBW_OK) {
            status = pbw__level_extremes(&build);
        }
        stride = stride > (build.early != NULL ? ratio * ratio : ratio) ? stride / ratio : stride > 1 ? 1 : 0;
        pbw__level_next(&build.level, stride);
    }
    for (i = 0; i < build.kernel_count; i++) {
        statistics->walk_steps += build.kernel[i]->statistics.walk_steps;
        statistics->conflict_tests += build.kernel[i]->statistics.conflict_tests;
        statistics->exact_tests += build.kernel[i]->statistics.exact_tests;
        statistics->created += build.kernel[i]->statistics.created;
        pbw__kernel_free(build.kernel[i]);
        pbw__release(memory, build.kernel[i], 1, sizeof(pbw__kernel));
    }
    PBW__RELEASE(memory, &build, left);
    pbw__release(memory, build.owner, store->region_count, 1);
    pbw__release(memory, build.early, vertices->count / 8 + 1, 1);
    return status != PBW_OK ? status
         : pbw__for_range(context, store->region_count, 256, 0.0, pbw__close_regions, store);
}
/* ------------------------------------------------------------------------------------------------------
   >>parallel     Ownership, and one level of vertices by many threads at once.
   In: a triangulation, the vertices to insert.  Out: the triangulation with them.   (Marot, Pellerin & Remacle 2019,
   "One machine, one minute, three billion tetrahedra", from whom the rule of ownership is)

   Vertices are owned in zones.  A zone is a span of ranks: one of the regions of >>slots, or, in coarse levels, as
   many regions as hold two vertices of coarser levels (in 2D one), so that a walk may find a simplex to start from.
   A zone is free or belongs to one task.  A task in 3D
     - deletes a simplex only if it owns three of its vertices,
     - walks through a facet only if it owns two of its vertices;
   in 2D it deletes a triangle only if it owns all its finite vertices, and walks through an edge if it owns one of
   its ends.  No task owns the ghost in 3D.  A task claims the free zones that it needs.  Where it needs a zone of
   another task, it leaves the vertex for the next round; no task ever waits.

     1. A task inserts the vertices of a share of the curve, one after the other, so an insertion mostly needs the
        zones of the last ones.  The zones of all tasks are a small part of all zones, and mostly far apart.
     2. A task keeps its zones.  It gives back the older half when they are many, and all of them when it leaves a
        vertex, when another task asks for one of them, and at the end.
     3. A task that leaves a vertex asks the owner of the missing zone.  The owner reads that word after its current
        vertex or later; a stale read only delays the hand-over, so relaxed order is enough.
     4. Shares are worked off in batches; after a batch the vertices left are tried again, as others have moved on.
     5. A task that has finished its own share continues with the ends of other shares, far from their tasks.
     6. A walk starts in the zone of its vertex or near it: a long one would claim zones all along.

   Why no word is written by one task while another reads or writes it, in 3D.  Call a simplex mine if I own two of
   its vertices: nobody else then owns three, so nobody else deletes it, and its corners do not change under me.
     (a) What I read is mine.  A facet of a simplex that I may delete has two vertices of mine, so the neighbour
     behind it is mine; a facet that I walk through too.
     (b) I write a link across a facet that my cavity has with a simplex outside it.  Two vertices of that facet are
     mine, so nobody else may walk through it, nor delete one of the simplices on its sides.  For the same reason the
     links that I read do not change.
     (c) A mark is set only on a simplex that its setter may delete: so nobody else looks at it (b).  Others stay 0;
     two tasks may write that same 0, therefore marks are read and written atomically, in relaxed order.
     (d) A slot belongs to the task that took it from a region of its zones, from its free list, or in a block of the
     tail.  The count of these is atomic, in relaxed order: it numbers slots, and what the slots hold is handed over
     at the end of a round (>>threads).
     (e) A zone's hint, where walks start, is a simplex with two vertices in the zone: mine, if the zone is.  The task
     that deletes it owns the zone, and stores another hint, or none, before it gives back any zone; until then the
     slot is still that task's own.  The hint, and what is left of the zone's regions, are the owner's to read and
     write; others only look whether there is a hint, before they take the zone, therefore hints are written
     atomically, in relaxed order.
   In 2D call a triangle mine if I own one of its vertices: nobody else then owns all of them.  Both ends of an edge
   of a triangle that I may delete are mine or the ghost, and one at least is finite; the rest is the same, with one
   vertex in the hint's zone.  Two tasks may share an edge's ghost end only.

   Claiming a zone acquires what its former owners released with it: zones are claimed in acquire order and given
   back in release order.  That is enough, because any two tasks of which one writes a word in (a), (b) or (c) that
   the other reads or writes, now or later, both own a vertex of the same simplex: of four vertices one owns three
   and the other two; of a facet's three vertices both own two.

   Why it ends.  Another round follows only if at least one in `tasks` tries succeeded; with fewer, one thread, which
   needs no zones, is as quick.  What is left then, or is too little for two tasks, is
   inserted by one thread, which owns everything, before the next level begins: vertices near the hull are among it,
   and cavities there would grow from level to level without them.
   ------------------------------------------------------------------------------------------------------ */
/* Claims a free zone; returns 0 if another task was faster, or we own too many. */
static PBW__NOINLINE int pbw__claim(pbw__kernel *kernel, size_t zone)
{
    pbw__ownership *own = &kernel->own;
    uint8_t nobody = PBW__NOBODY;
    PBW__TEST_PAUSE();
    if (own->claim_count == PBW__CLAIMS || !PBW__CAS_ACQUIRE(own->owner + zone, &nobody, own->me)) {
        return 0;
    }
    own->claim[own->claim_count++] = (pbw_index)zone;
    return 1;
}

PBW__INLINE int pbw__owns_zone(pbw__kernel *kernel, size_t zone)
{
    uint8_t owner = PBW__LOAD(kernel->own.owner + zone);
    if (owner == kernel->own.me || (owner == PBW__NOBODY && pbw__claim(kernel, zone))) {
        return 1;
    }
    kernel->own.blocker = owner;
    return 0;
}

PBW__INLINE int pbw__owns(pbw__kernel *kernel, pbw_index v)
{
    return v != PBW__GHOST && pbw__owns_zone(kernel, v >> kernel->own.owner_bits);
}

PBW__INLINE unsigned pbw__is_ours(const pbw__kernel *kernel, pbw_index v)
{
    return (v != PBW__GHOST) & (PBW__LOAD(kernel->own.owner + (v >> kernel->own.owner_bits)) == kernel->own.me);
}

/* Claims zones for lacking corners until `wanted` corners are ours, and no more: other tasks may need the rest. */
static PBW__NOINLINE int pbw__take_corners(pbw__kernel *kernel, const pbw_index *v, unsigned except, int wanted)
{
    unsigned k, others = 0;
    for (k = 0; k <= (unsigned)kernel->dim; k++) {
        unsigned ours = pbw__is_ours(kernel, v[k]);
        wanted -= (int)ours & (k != except);
        others |= ((ours ^ 1u) & (k != except)) << k;
    }
    for (k = 0; wanted > 0 && others >> k != 0; k++) {
        wanted -= (others >> k & 1) != 0 && pbw__owns(kernel, v[k]);
    }
    return wanted <= 0;
}

PBW__INLINE int pbw__may_delete(pbw__kernel *kernel, pbw_index t)
{
    const pbw_index *v = kernel->corner + 4 * (size_t)t;
    unsigned ours = pbw__is_ours(kernel, v[0]) + pbw__is_ours(kernel, v[1]) + pbw__is_ours(kernel, v[2]);
    unsigned wanted = kernel->dim == 2 && v[2] == PBW__GHOST ? 2 : 3;
    ours += kernel->dim == 3 ? pbw__is_ours(kernel, v[3]) : 0;
    return ours >= wanted || pbw__take_corners(kernel, v, 4, (int)wanted);
}

PBW__INLINE int pbw__may_cross(pbw__kernel *kernel, pbw_index t, unsigned facet)
{
    const pbw_index *v = kernel->corner + 4 * (size_t)t;
    unsigned ours = pbw__is_ours(kernel, v[facet == 0]) + pbw__is_ours(kernel, v[facet < 2 ? 2 : 1]);
    ours += kernel->dim == 3 ? pbw__is_ours(kernel, v[facet == 3 ? 2 : 3]) : 0;
    return (int)ours >= kernel->dim - 1 || pbw__take_corners(kernel, v, facet, kernel->dim - 1);
}

#ifdef PBW__SIMD
/* Returns the set of those of four corners that are not ours. */
PBW__INLINE unsigned pbw__lacking4(const pbw__kernel *kernel, pbw_index a, pbw_index b, pbw_index c, pbw_index d)
{
    return 15u ^ (pbw__is_ours(kernel, a) | pbw__is_ours(kernel, b) << 1 | pbw__is_ours(kernel, c) << 2
                  | pbw__is_ours(kernel, d) << 3);
}

/* Returns whether we may delete the neighbours in conflict of a simplex of which we do not own one corner.  Of the
   neighbour across from that corner we own three corners; of each other neighbour two, so we claim its far vertex.
   Far vertices come first: the missing corner usually has a large star that other tasks need. */
static PBW__NOINLINE int pbw__may_delete_all(pbw__kernel *kernel, const pbw__carved *carved, unsigned lacking,
                                             unsigned inside)
{
    const pbw_index *corner = kernel->corner;
    const pbw__link *link = carved->link;
    unsigned set = inside & ~lacking;
    set &= pbw__lacking4(kernel, corner[link[0]], corner[link[1]], corner[link[2]], corner[link[3]]);
    for (; set != 0; set &= set - 1) {
        if (!pbw__owns(kernel, corner[link[__builtin_ctz(set)]])) {
            return pbw__owns(kernel, carved->v[__builtin_ctz(lacking)]);
        }
    }
    return 1;
}
#endif

static void pbw__round_begin(pbw__build *build, int task)
{
    pbw__kernel *kernel = build->kernel[task];
    pbw__kernel_attach(kernel);                      /* the store may have moved */
    kernel->own.owner = build->owner;
    kernel->own.owner_bits = build->owner_bits;
    kernel->own.me = (uint8_t)task;
    kernel->slots.region = (size_t)-1;
    kernel->last = PBW_NONE;
    kernel->left_count = 0;
    kernel->own.claim_count = kernel->own.renewed = 0;
    kernel->own.missed = 0;
    kernel->own.blocker = PBW__NOBODY;
    kernel->scratch.facet_count = 0;
    kernel->slots.no_room = 0;
    kernel->status = PBW_OK;
}

/* Returns whether a simplex is mine if I own the zone. */
static int pbw__is_in_zone(const pbw__build *build, pbw_index t, size_t zone)
{
    const int dim = build->vertices->dim;
    const pbw_index *corner = build->store->corner;
    size_t i = 4 * (size_t)t;
    int count = 0, k;
    if (t == PBW_NONE || corner[i] == PBW_NONE) {
        return 0;
    }
    for (k = 0; k <= dim; k++, i++) {
        count += corner[i] != PBW__GHOST && corner[i] >> build->owner_bits == zone;
    }
    return count + 1 >= dim;
}

/* Makes a simplex of a vertex's star the hint of the vertex's zone: the next vertex may be near.  In 2D any simplex
   of the star will do. */
static void pbw__renew_hint(pbw__build *build, pbw__kernel *kernel, pbw_index vertex)
{
    const size_t zone = vertex >> build->owner_bits;
    pbw_index hint = kernel->last;
    size_t i;
    for (i = 0; kernel->dim == 3 && !pbw__is_in_zone(build, hint, zone); i++) {
        if (i == kernel->scratch.facet_count) {
            return;
        }
        hint = kernel->scratch.cavity[i];
    }
    PBW__STORE(build->store->hint + pbw__first_region(build, zone), hint);
}

/* Makes a simplex the hint of those zones of this owner that it lies in and that have none. */
static void pbw__offer_hint(pbw__build *build, pbw_index t, uint8_t owner)
{
    const pbw_index *v = build->store->corner + 4 * (size_t)t;
    int k;
    for (k = 0; k <= build->vertices->dim && v[k] != PBW__GHOST; k++) {          /* the ghost is the last corner */
        const size_t zone = v[k] >> build->owner_bits;
        pbw_index *hint = build->store->hint + pbw__first_region(build, zone);
        if (PBW__LOAD(hint) == PBW_NONE && PBW__LOAD(build->owner + zone) == owner
            && pbw__is_in_zone(build, t, zone)) {
            PBW__STORE(hint, t);
        }
    }
}

/* Gives back the first `count` of our zones.  If simplices were made, all our zones get new hints before that: the
   slot of an old hint may hold a simplex that another task may delete from now on. */
static void pbw__give_back(pbw__build *build, pbw__kernel *kernel, int count)
{
    pbw_index v[4] = { PBW__GHOST, PBW__GHOST, PBW__GHOST, PBW__GHOST };
    size_t t;
    int i, k, ours = 0, missing = 0;
    pbw__leave_region(kernel);
    for (i = 0; kernel->own.renewed && i < kernel->own.claim_count; i++) {
        const size_t zone = kernel->own.claim[i];
        pbw_index *hint = build->store->hint + pbw__first_region(build, zone);
        if (!pbw__is_in_zone(build, *hint, zone)) {
            PBW__STORE(hint, PBW_NONE);
            missing = 1;
        }
    }
    for (t = 0; missing && t < kernel->scratch.facet_count; t++) {
        pbw__offer_hint(build, kernel->scratch.cavity[t], kernel->own.me);
    }
    for (k = 0; kernel->last != PBW_NONE && k <= kernel->dim; k++) {
        v[k] = kernel->corner[4 * (size_t)kernel->last + (size_t)k];     /* may change once zones are given back */
    }
    for (i = 0; i < count; i++) {
        PBW__STORE_RELEASE(kernel->own.owner + kernel->own.claim[i], PBW__NOBODY);
        PBW__TEST_PAUSE();
    }
    kernel->own.claim_count -= count;
    memmove(kernel->own.claim, kernel->own.claim + count, (size_t)kernel->own.claim_count * sizeof(pbw_index));
    for (k = 0; k <= kernel->dim; k++) {
        ours += (int)pbw__is_ours(kernel, v[k]);
    }
    kernel->last = ours + 1 >= kernel->dim ? kernel->last : PBW_NONE;
    kernel->own.renewed = 0;
    kernel->scratch.facet_count = 0;
}

/* Inserts a vertex, claiming zones for it, and keeps them for the next vertices, which are often near.  If another
   task asks for one of the zones, gives back all: it needs the zones around, too. */
static pbw_status pbw__insert_claiming(pbw__build *build, pbw__kernel *kernel, pbw_index v)
{
    size_t created = kernel->statistics.created;
    pbw_status status = pbw__owns_zone(kernel, v >> build->owner_bits) && pbw__find_start(build, kernel, v)
                      ? kernel->insert(kernel, v) : PBW__DEFERRED;
    if (status != PBW_OK && status != PBW__DEFERRED) {
        return status;                               /* the star may be incomplete: its zones stay taken */
    }
    if (kernel->statistics.created > created) {
        pbw__renew_hint(build, kernel, v);
        kernel->own.renewed = 1;
    } else {
        kernel->scratch.facet_count = 0;
    }
    if (PBW__UNLIKELY(status == PBW__DEFERRED)) {
        kernel->own.missed++;
        if (kernel->own.blocker != PBW__NOBODY) {
            PBW__STORE(&build->kernel[kernel->own.blocker]->asked, 1);
        }
    }
    if (PBW__UNLIKELY(status == PBW__DEFERRED) || PBW__UNLIKELY(PBW__LOAD(&kernel->asked))) {
        PBW__STORE(&kernel->asked, 0);
        pbw__give_back(build, kernel, kernel->own.claim_count);
    } else if (kernel->own.claim_count > build->hold) {
        pbw__give_back(build, kernel, (kernel->own.claim_count + 1) / 2);
    }
    return status;
}

/* Frees zones before the first round of a level; each keeps a hint that lies in it, or gets none. */
static pbw_status pbw__begin_zones(void *arg, size_t zone, size_t end)
{
    pbw__build *build = (pbw__build *)arg;
    pbw_index *hint = build->store->hint;
    size_t r, last;
    memset(build->owner + zone, PBW__NOBODY, end - zone);
    for (; zone < end; zone++) {
        r = pbw__first_region(build, zone);
        last = pbw__first_region(build, zone + 1);
        if (!pbw__is_in_zone(build, hint[r], zone)) {
            hint[r] = PBW_NONE;
        }
        while (++r < last) {
            hint[r] = PBW_NONE;
        }
    }
    return PBW_OK;
}

/* Finds hints for zones that have none, among the simplices of some regions. */
static pbw_status pbw__find_hints(void *arg, size_t r, size_t last)
{
    pbw__build *build = (pbw__build *)arg;
    const pbw__store *store = build->store;
    size_t t;
    for (; r < last; r++) {
        for (t = r > 0 ? pbw__region_end(store, r - 1) : 0; t < store->region[r]; t++) {
            if (store->corner[4 * t] != PBW_NONE) {
                pbw__offer_hint(build, (pbw_index)t, PBW__NOBODY);
            }
        }
    }
    return PBW_OK;
}

/* Inserts vertices from..to-1 of a round: in the first round of the level, later of those left.  Then retries those
   that it left, while each try lowers their number by a quarter, as other tasks move on.  Returns 0 to stop. */
static int pbw__batch(pbw__build *build, pbw__kernel *kernel, size_t from, size_t to)
{
    const pbw__level level = build->level;
    const int again = build->left_count > 0;
    const size_t first = kernel->left_count;
    size_t i, rank = again ? 0 : pbw__level_rank(&level, from), last = to - from, end;
    for (i = from; i < to; i++, rank = pbw__level_after(&level, rank)) {
        const pbw_index v = again ? build->left[i] : (pbw_index)rank + 1;
        if ((again || !pbw__is_early(build, rank)) && !pbw__level_insert(build, kernel, v)) {
            return 0;
        }
    }
    for (end = kernel->left_count; end > first && 4 * (end - first) < 3 * last; end = kernel->left_count) {
        last = end - first;
        kernel->left_count = first;
        for (i = first; i < end; i++) {
            if (!pbw__level_insert(build, kernel, kernel->left[i])) {
                return 0;
            }
        }
    }
    return 1;
}

/* Inserts the vertices of a round, in batches: first those of the task's own share, then those of other shares, from
   the ends, where no other task is at work. */
static void pbw__round(void *arg, int task)
{
    pbw__build *build = (pbw__build *)arg;
    pbw__kernel *kernel = build->kernel[task];
    int k;
    pbw__round_begin(build, task);
    for (k = 0; k < build->tasks; k++) {
        const int share = (task + k) % build->tasks;
        const size_t begin = pbw__share(build->count, share, build->tasks);
        const size_t end = pbw__share(build->count, share + 1, build->tasks);
        const size_t least = (end - begin + PBW__BATCHES - 1) / PBW__BATCHES;
        const size_t batch = least < PBW__BATCH ? PBW__BATCH : least, batches = (end - begin + batch - 1) / batch;
        uint32_t taken = PBW__LOAD(build->taken + share);
        kernel->own.share = (uint8_t)share;
        while ((taken & 65535) + (taken >> 16) < batches) {
            size_t from;
            if (!PBW__CAS(build->taken + share, &taken, taken + (k == 0 ? 1 : 65536))) {
                continue;
            }
            from = begin + (k == 0 ? taken & 65535 : batches - 1 - (taken >> 16)) * batch;
            if (!pbw__batch(build, kernel, from, from + batch < end ? from + batch : end)) {
                return;
            }
            taken = PBW__LOAD(build->taken + share);
        }
    }
    pbw__give_back(build, kernel, kernel->own.claim_count);
}

/* Ends a round: collects the vertices left, grows the store if a task found no room. */
static pbw_status pbw__end_round(pbw__build *build)
{
    pbw__store *store = build->store;
    size_t count = 0, missed = 0, inserted;
    int task, no_room = 0;
    pbw_status status = PBW_OK;
    for (task = 0; task < build->tasks; task++) {
        pbw__kernel *kernel = build->kernel[task];
        count += kernel->left_count;
        missed += kernel->own.missed;
        no_room |= kernel->slots.no_room;
        status = status != PBW_OK ? status : kernel->status;
        build->done += kernel->done;
        kernel->done = 0;
    }
    if (status != PBW_OK) {
        return status;
    }
    if (count > build->left_capacity && !PBW__RESIZE(&build->context->memory, build, left, count)) {
        return PBW_ERROR_MEMORY;
    }
    build->left_count = 0;
    for (task = 0; task < build->tasks; task++) {
        pbw__kernel *kernel = build->kernel[task];
        if (kernel->left_count > 0) {
            memcpy(build->left + build->left_count, kernel->left, kernel->left_count * sizeof(pbw_index));
        }
        build->left_count += kernel->left_count;
    }
    build->trace += 256;
    build->statistics->rounds++;
    build->statistics->postponed += count;
    inserted = build->count - count;
    build->count = count;
    if (no_room && store->capacity < PBW__SIMPLEX_LIMIT) {
        status = pbw__store_reserve(build->context, store, pbw__store_bigger(store, inserted < count));
    } else if ((size_t)build->tasks * inserted < inserted + missed) {
        build->tasks = 1;                            /* tasks are in each other's way */
    }
    return status;
}

/* Inserts the level, or the vertices left, by rounds. */
static pbw_status pbw__rounds(pbw__build *build)
{
    pbw__context *context = build->context;
    const size_t zones = (build->vertices->count >> build->owner_bits) + 1;
    const size_t hold = zones / (size_t)build->tasks / PBW__HOLDS + 8;
    pbw_status status = pbw__more_kernels(build, context->threads < PBW__TASKS ? context->threads : PBW__TASKS);
    if (build->owner == NULL) {
        build->owner = (uint8_t *)pbw__allocate(&context->memory, build->store->region_count, 1);
    }
    if (status != PBW_OK || build->owner == NULL) {
        return PBW_ERROR_MEMORY;
    }
    status = pbw__for_range(context, zones, 4096, 0.0, pbw__begin_zones, build);
    if (status == PBW_OK && build->hint_bits != build->owner_bits) {     /* finer zones: there are few */
        status = pbw__for_range(context, build->store->region_count, 64, 0.0, pbw__find_hints, build);
        build->hint_bits = build->owner_bits;
    }
    if (status != PBW_OK) {
        return status;
    }
    build->hold = (int)(hold < PBW__HOLD ? hold : PBW__HOLD);
    build->count = build->left_count > 0 ? build->left_count : pbw__level_size(&build->level);
    do {
        memset(build->taken, 0, sizeof(build->taken));
        pbw__for(context, build->tasks, pbw__round, build);
        status = pbw__end_round(build);
        if (build->left_count < PBW__LEAST_SHARE * (size_t)build->tasks) {
            build->tasks = (int)(build->left_count / PBW__LEAST_SHARE);
        }
    } while (status == PBW_OK && build->tasks > 1);
    return status;
}
/* ------------------------------------------------------------------------------------------------------
   >>number       The canonical order of the simplices.
   In: a finished triangulation of ranks.  Out: for each slot the position of its simplex in the caller's arrays; for
   each rank the position of its first simplex.

   Canonical form of a simplex: by an even permutation of the corners, the lowest rank comes first and the lowest of
   the rest second (2D: the lowest first).  Canonical order: by the ranks of the corners, first to last.  So the
   simplices follow the Hilbert curve, and any method that finds the triangulation can produce the same arrays.

   Each simplex belongs to the list of its lowest rank.  Pass 1 counts the lists and chains the slots of each region's
   lists.  Pass 2 sorts the lists, region by region, and numbers their simplices.
   ------------------------------------------------------------------------------------------------------ */
/* A simplex in the list of its lowest rank.  In space the key holds the second and the third corner, `last` is the
   fourth.  In the plane the key holds the first and the second corner: one triangle lies to the left of that edge. */
typedef struct pbw__item { uint64_t key; pbw_index simplex, last; } pbw__item;

/* A simplex in canonical form, with the caller's ids and the positions of its neighbours. */
typedef struct pbw__emitted {
    pbw_index position, corner[4], neighbor[4];
} pbw__emitted;

/* Simplices read before their positions were free.  Positions free_from .. free_from+free_count-1 are free. */
typedef struct pbw__aside {
    pbw__emitted *simplex;
    size_t count, capacity, free_from, free_count;
} pbw__aside;

/* What a task keeps from pass to pass; end: its chain for others, then where its positions end; ghosts: how many are
   in its share of the slots, then the number of the next one. */
typedef struct pbw__emitting { size_t end, ghosts; pbw__aside aside; } pbw__emitting;

#define PBW__CHAINS 16                               /* followed at a time, so that their cache misses overlap */
#define PBW__SOON 48                                 /* distance of prefetches in arrays that are read in any order */
#define PBW__LISTS 64                                /* sorted at a time */
#define PBW__REACH 11                                /* a simplex may be so far from its position, in the plane */
#define PBW__SHORT 48                                /* simplices of the longest list that is not a hub's */

typedef struct pbw__emission {
    pbw__context *context;
    const pbw__store *store;
    pbw_index *corner;
    pbw__link *link;                                 /* NULL: not wanted */
    pbw_index *to_corner, *to_link;                  /* where simplices are written: the arrays above or new ones */
    size_t slot_count, simplex_count, vertex_count, visible;
    size_t rank_entries;                             /* of `head` and `first`, in the block of the records */
    int dim, any_order, tasks, failed, simd;
    int apart, links_apart;                          /* into new arrays */
    int packed;                                      /* into slots, with corners and links as they are, ghosts last */
    int placing;                                     /* 0: ghosts are counted */
    const pbw_index *id;                             /* per rank */
    pbw_index *number;                               /* per slot: the next of its chain; then its position */
    pbw_index *chain;                                /* per region: the last slot of its chain */
    pbw_index *head;                                 /* per rank: the length of its list; then its first simplex */
    pbw_index *first;                                /* per rank, tasks > 1: its first simplex in earlier shares */
    pbw_index *incident;                             /* per point of the caller */
    int chunk_bits;                                  /* slot >> chunk_bits is the number of its chunk */
    size_t chunk;                                    /* the next to be read, in the order of >>output */
    unsigned char *chunk_done;
    pbw__emitting *task, one_task;                   /* per task; room for one */
} pbw__emission;

/* The even permutation of the canonical form: corner k of the output is corner (order >> 2k) & 3 here.  Branchless:
   looked up by which of the pairs (0,1) (0,2) (1,2) (0,3) (1,3) (2,3), in 2D of the first three, are descending. */
static const uint32_t pbw__turn3[64] = {
    228, 177, 0, 201, 120, 0, 210, 54, 0, 0, 0, 201, 0, 0, 0, 54,
    0, 0, 0, 0, 120, 0, 210, 0, 0, 0, 0, 0, 0, 0, 78, 78,
    228, 177, 0, 0, 0, 0, 0, 0, 0, 45, 0, 45, 0, 0, 0, 0,
    156, 0, 0, 0, 156, 0, 0, 0, 99, 135, 0, 135, 99, 0, 27, 27 };
static const uint32_t pbw__turn2[8] = { 36, 9, 0, 9, 36, 0, 18, 18 };
#define PBW__IN_ORDER 228u                            /* the identity */

PBW__INLINE unsigned pbw__canonical_order(const pbw_index *v, int dim)
{
    const int pairs = (v[0] > v[1]) | (v[0] > v[2]) << 1 | (v[1] > v[2]) << 2;
    return dim == 2 ? pbw__turn2[pairs]
                    : pbw__turn3[pairs | (v[0] > v[3]) << 3 | (v[1] > v[3]) << 4 | (v[2] > v[3]) << 5];
}

#ifdef PBW__AVX2
/* pbw__canonical_order as lane numbers. */
PBW__SIMD_INLINE pbw__i4 pbw__canonical_lanes(pbw__i4 v, int dim)
{
    const __m256i both = _mm256_castsi128_si256((__m128i)v);
    const __m256i a = _mm256_permutevar8x32_epi32(both, _mm256_setr_epi32(0, 0, 1, 0, 1, 2, 0, 0));
    const __m256i b = _mm256_permutevar8x32_epi32(both, _mm256_setr_epi32(1, 2, 2, 3, 3, 3, 0, 0));
    const __m256i descending = _mm256_cmpeq_epi32(_mm256_max_epu32(a, b), a);
    const unsigned pairs = (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(descending));
    const uint32_t order = dim == 3 ? pbw__turn3[pairs & 63] : pbw__turn2[pairs & 7];
    return (pbw__i4)_mm_srlv_epi32(_mm_set1_epi32((int)order), _mm_setr_epi32(0, 2, 4, 6));
}
#endif

/* Lists the slots from..end-1 that hold a simplex and no ghost, with its lowest rank.  Returns how many.  Branchless:
   on a circle half are ghosts, in unpredictable slots. */
static size_t pbw__lowest_ranks_scalar(const pbw_index *corner, size_t from, size_t end, pbw_index *slot,
                                       pbw_index *low, int dim)
{
    size_t used = 0;
    for (; from < end; from++) {
        const pbw_index *v = corner + 4 * from;
        pbw_index least = v[0] < v[1] ? v[0] : v[1];
        least = v[2] < least ? v[2] : least;
        low[used] = dim == 3 && v[3] < least ? v[3] : least;
        slot[used] = (pbw_index)from;
        used += (v[0] != PBW_NONE) & (low[used] != 0);
    }
    return used;
}

#ifdef PBW__AVX2
PBW__SIMD static size_t pbw__lowest_ranks_simd(const pbw_index *corner, size_t from, size_t end, pbw_index *slot,
                                               pbw_index *low, int dim)
{
    const __m128i zero = _mm_setzero_si128(), unused = dim == 3 ? zero : _mm_setr_epi32(0, 0, -1, -1);
    const pbw__i4 lanes = { 0, 1, 2, 3 };
    size_t used = 0;
    for (; from + 4 <= end; from += 4) {
        const __m128i *v = (const __m128i *)(const void *)(corner + 4 * from);
        const __m128i a = _mm_loadu_si128(v), b = _mm_loadu_si128(v + 1), ab = _mm_unpacklo_epi32(a, b);
        const __m128i c = _mm_loadu_si128(v + 2), d = _mm_loadu_si128(v + 3), cd = _mm_unpacklo_epi32(c, d);
        const __m128i x = _mm_min_epu32(ab, _mm_or_si128(_mm_unpackhi_epi32(a, b), unused));
        const __m128i y = _mm_min_epu32(cd, _mm_or_si128(_mm_unpackhi_epi32(c, d), unused));
        const __m128i least = _mm_min_epu32(_mm_unpacklo_epi64(x, y), _mm_unpackhi_epi64(x, y));
        const __m128i free = _mm_cmpeq_epi32(_mm_unpacklo_epi64(ab, cd), _mm_set1_epi32(-1));
        const __m128i ghost = _mm_cmpeq_epi32(least, zero);
        const unsigned set = 15u ^ (unsigned)_mm_movemask_ps((__m128)_mm_or_si128(free, ghost));
        pbw__store4(slot + used, pbw__shuffle4(pbw__splat_i((int32_t)from) + lanes, pbw__front[set]));
        pbw__store4(low + used, pbw__shuffle4((pbw__i4)least, pbw__front[set]));
        used += pbw__count4(set);
    }
    return used + pbw__lowest_ranks_scalar(corner, from, end, slot + used, low + used, dim);
}
#endif

/* ---- pass 1: lists
   A task reads the slots of a range of regions and makes the lists of the ranks of these regions.  The few simplices
   for lists of other tasks are chained apart, and added by pbw__emit_others with atomic exchanges. */

/* A task owns the lists of `own` ranks from `ranks` on; `others`: the last slot of its chain for other tasks. */
typedef struct pbw__listing { size_t ranks, own; pbw_index others; } pbw__listing;

/* Chains the slots from..end-1. */
static void pbw__emit_chains(const pbw__emission *emission, pbw__listing *listing, size_t from, size_t end)
{
    pbw_index *number = emission->number, *chain = emission->chain, *head = emission->head;
    pbw_index slot[PBW__BATCH], low[PBW__BATCH];
    const size_t ranks = listing->ranks, own = listing->own;
    const int bits = emission->store->region_bits;
    size_t t, to, used, i;
    for (; from < end; from = to) {
        if ((from / PBW__BATCH & 1023) == 0
            && pbw__report(emission->context, 0.25 * (double)from / (double)emission->slot_count)) {
            break;
        }
        to = end - from < PBW__BATCH ? end : from + PBW__BATCH;
        for (t = to; t < end && t < to + PBW__BATCH; t += 4) {
            PBW__PREFETCH(emission->corner + 4 * t);
        }
        memset(number + from, 0xff, (to - from) * sizeof(pbw_index));            /* PBW_NONE */
#ifdef PBW__AVX2
        if (emission->simd) {
            used = pbw__lowest_ranks_simd(emission->corner, from, to, slot, low, emission->dim);
        } else
#endif
        {
            used = pbw__lowest_ranks_scalar(emission->corner, from, to, slot, low, emission->dim);
        }
        for (i = 0; i < used; i++) {
            pbw_index *last = &listing->others;
            if (PBW__LIKELY(low[i] - ranks < own)) {
                last = chain + (low[i] >> bits);
                head[low[i]]++;
            }
            number[slot[i]] = *last;
            *last = slot[i];
        }
    }
}

/* Returns the first rank of a region; past the last region, the number of ranks. */
PBW__INLINE size_t pbw__emit_ranks(const pbw__emission *emission, size_t region)
{
    size_t ranks = region << emission->store->region_bits;
    return ranks <= emission->vertex_count ? ranks : emission->vertex_count + 1;
}

/* Returns the first slot of the region that lies `before` regions before this one, or of the first region. */
PBW__INLINE size_t pbw__emit_start(const pbw__emission *emission, size_t region, size_t before)
{
    return region > before ? pbw__region_end(emission->store, region - before - 1) : 0;
}

static void pbw__emit_pass1(void *arg, int task)
{
    pbw__emission *emission = (pbw__emission *)arg;
    const pbw__store *store = emission->store;
    size_t first = pbw__share(store->region_count, task, emission->tasks);
    size_t last = pbw__share(store->region_count, task + 1, emission->tasks);
    size_t from = first > 0 ? pbw__region_end(store, first - 1) : 0;
    size_t to = last > 0 ? pbw__region_end(store, last - 1) : 0, tail = store->count - store->region_slots;
    size_t tail_from = store->region_slots + pbw__share(tail, task, emission->tasks);
    size_t tail_to = store->region_slots + pbw__share(tail, task + 1, emission->tasks);
    size_t ranks = pbw__emit_ranks(emission, first), end = pbw__emit_ranks(emission, last);
    pbw__listing listing = { first << store->region_bits, (last - first) << store->region_bits, PBW_NONE };
    memset(emission->chain + first, 0xff, (last - first) * sizeof(pbw_index));       /* PBW_NONE */
    memset(emission->head + ranks, 0, (end - ranks) * sizeof(pbw_index));
    if (emission->first != NULL) {
        memset(emission->first + ranks, 0xff, (end - ranks) * sizeof(pbw_index));
    }
    pbw__emit_chains(emission, &listing, from, to);
    pbw__emit_chains(emission, &listing, tail_from, tail_to);
    emission->task[task].end = listing.others;
}

static void pbw__emit_others(void *arg, int task)
{
    pbw__emission *emission = (pbw__emission *)arg;
    pbw_index t = (pbw_index)emission->task[task].end, next, low, *last;
    for (; t != PBW_NONE; t = next) {
        const pbw_index *v = emission->corner + 4 * (size_t)t;
        next = emission->number[t];
        low = v[pbw__canonical_order(v, emission->dim) & 3];
        last = emission->chain + (low >> emission->store->region_bits);
        emission->number[t] = PBW__LOAD(last);
        while (!PBW__CAS(last, emission->number + t, t)) {
        }
        (void)PBW__ADD(emission->head + low, 1);
    }
}

/* Returns the number of simplices in some lists. */
PBW__INLINE size_t pbw__emit_count(const pbw_index *length, size_t lists)
{
    size_t i, sum = 0;
    for (i = 0; i < lists; i++) {
        sum += length[i];
    }
    return sum;
}

static void pbw__emit_counts(void *arg, int task)
{
    const pbw__emission *emission = (const pbw__emission *)arg;
    size_t regions = emission->store->region_count;
    size_t from = pbw__emit_ranks(emission, pbw__share(regions, task, emission->tasks));
    size_t to = pbw__emit_ranks(emission, pbw__share(regions, task + 1, emission->tasks));
    emission->task[task].end = pbw__emit_count(emission->head + from, to - from);
}

/* ---- lists in order
   Appends simplices to their lists: end[rank] is the next free item of a list. */
PBW__INLINE void pbw__fill_lists_of(const pbw_index *corner, const pbw_index *slot, size_t count, pbw_index *end,
                                    pbw__item *item, int dim)
{
    size_t i;
    for (i = 0; i < count; i++) {
        const pbw_index *v = corner + 4 * (size_t)slot[i];
        unsigned order = pbw__canonical_order(v, dim);
        pbw__item *to = item + end[v[order & 3]]++;
        order = dim == 3 ? order >> 2 : order;
        to->key = (uint64_t)v[order & 3] << 32 | v[order >> 2 & 3];
        to->simplex = slot[i];
        to->last = v[order >> 4 & 3];
    }
}

PBW__INLINE void pbw__sift(pbw__item *heap, size_t root, size_t count)
{
    pbw__item item = heap[root];
    size_t child;
    while ((child = 2 * root + 1) < count) {
        child += child + 1 < count && heap[child + 1].key > heap[child].key;
        if (heap[child].key <= item.key) {
            break;
        }
        heap[root] = heap[child];
        root = child;
    }
    heap[root] = item;
}

/* Sorts the list of a hub, a vertex with many simplices: a heap sort. */
static PBW__NOINLINE void pbw__sort_hub(pbw__item *heap, size_t count, pbw__item *sorted)
{
    size_t i;
    for (i = count / 2; i-- > 0; ) {
        pbw__sift(heap, i, count);
    }
    for (i = count; i-- > 0; ) {
        sorted[i] = heap[0];
        heap[0] = heap[i];
        pbw__sift(heap, 0, i);
    }
}

/* Sorts lists by their keys.  The first list begins at item `begin`, each ends at its `end`, where the next
   begins.  Results start at sorted[1]; sorted[0] is scratch.  Branchless, as the order is unpredictable: an item goes
   behind as many others as have lower keys. */
static void pbw__sort_lists(pbw__item *item, const pbw_index *end, unsigned lists, pbw_index begin,
                            pbw__item *sorted)
{
    unsigned rank[PBW__SHORT], i, j, l;
    for (l = 0; l < lists; begin = end[l++]) {
        unsigned count = end[l] - begin <= PBW__SHORT ? end[l] - begin : 0;
        for (i = 0; i < count; i++) {
            for (rank[i] = 0, j = 0; j < i; j++) {
                unsigned above = item[begin + i].key > item[begin + j].key;
                rank[i] += above;
                rank[j] += 1 - above;
            }
        }
        for (i = 0; i < count; i++) {
            sorted[1 + begin + rank[i]] = item[begin + i];
        }
        if (count == 0) {                            /* an empty list, or a hub's */
            pbw__sort_hub(item + begin, end[l] - begin, sorted + 1 + begin);
        }
    }
}

#ifdef PBW__AVX2
/* Exchanges a and b in lanes where a is larger; inverts `odd` there.  Ranks are below PBW__POINT_LIMIT, 2^31. */
PBW__SIMD_INLINE void pbw__ascend(__m256i *a, __m256i *b, __m256i *odd)
{
    const __m256i low = _mm256_min_epu32(*a, *b);
    *odd = _mm256_xor_si256(*odd, _mm256_cmpgt_epi32(*a, *b));
    *b = _mm256_max_epu32(*a, *b);
    *a = low;
}

PBW__SIMD_INLINE void pbw__transpose(__m256i *row)   /* transposes both halves of the four rows */
{
    const __m256i a = _mm256_unpacklo_epi32(row[0], row[1]), b = _mm256_unpackhi_epi32(row[0], row[1]);
    const __m256i c = _mm256_unpacklo_epi32(row[2], row[3]), d = _mm256_unpackhi_epi32(row[2], row[3]);
    row[0] = _mm256_unpacklo_epi64(a, c);
    row[1] = _mm256_unpackhi_epi64(a, c);
    row[2] = _mm256_unpacklo_epi64(b, d);
    row[3] = _mm256_unpackhi_epi64(b, d);
}

/* pbw__fill_lists_of for eight simplices at a time, a lane each: one by one takes three times as long.  Sorts the
   corners; the canonical form has the last two the other way round if that took an odd number of exchanges. */
PBW__SIMD_INLINE void pbw__fill_lists_simd_of(const pbw_index *corner, const pbw_index *slot, size_t count,
                                              pbw_index *end, pbw__item *item, int dim)
{
    size_t i, k;
    for (i = 0; i + 8 <= count; i += 8) {
        __m256i v[4], entry[4], odd = _mm256_setzero_si256();
        pbw_index rank[8];
        for (k = 0; k < 4; k++) {
            v[k] = _mm256_castsi128_si256((__m128i)pbw__load4(corner + 4 * (size_t)slot[i + k]));
            v[k] = _mm256_inserti128_si256(v[k], (__m128i)pbw__load4(corner + 4 * (size_t)slot[i + k + 4]), 1);
        }
        pbw__transpose(v);
        pbw__ascend(v, v + 1, &odd);
        pbw__ascend(v + dim - 1, v + dim, &odd);
        pbw__ascend(v, v + dim - 1, &odd);
        if (dim == 3) {
            pbw__ascend(v + 1, v + 3, &odd);
            pbw__ascend(v + 1, v + 2, &odd);
        }
        _mm256_storeu_si256((__m256i *)(void *)rank, v[0]);
        entry[0] = (__m256i)_mm256_blendv_ps((__m256)v[dim - 1], (__m256)v[dim], (__m256)odd);
        entry[1] = v[dim - 2];
        entry[2] = _mm256_loadu_si256((const __m256i *)(const void *)(slot + i));
        entry[3] = (__m256i)_mm256_blendv_ps((__m256)v[dim], (__m256)v[dim - 1], (__m256)odd);
        pbw__transpose(entry);
        for (k = 0; k < 8; k++) {
            pbw__store4(item + end[rank[k]]++, (pbw__i4)(k < 4 ? _mm256_castsi256_si128(entry[k % 4])
                                                               : _mm256_extracti128_si256(entry[k % 4], 1)));
        }
    }
    pbw__fill_lists_of(corner, slot + i, count - i, end, item, dim);
}

PBW__SIMD static void pbw__fill_lists_simd(const pbw__emission *emission, const pbw_index *slot, size_t count,
                                           pbw__item *item)
{
    PBW__BY_DIM(emission->dim, pbw__fill_lists_simd_of, emission->corner, slot, count, emission->head, item);
}

/* Returns the keys of four items. */
PBW__SIMD_INLINE __m256i pbw__keys4(const pbw__item *item)
{
    const __m256i a = _mm256_loadu_si256((const __m256i *)(const void *)item);
    const __m256i b = _mm256_loadu_si256((const __m256i *)(const void *)(item + 2));
    return _mm256_permute4x64_epi64(_mm256_unpacklo_epi64(a, b), 0xd8);
}

/* Writes four items to their positions. */
PBW__SIMD_INLINE void pbw__put4(const pbw__item *item, __m256i position, pbw__item *sorted)
{
    uint64_t *to = (uint64_t *)(void *)sorted, half[4];
    _mm256_storeu_si256((__m256i *)(void *)half, _mm256_add_epi64(position, position));
    pbw__store4(to + half[0], pbw__load4(item));
    pbw__store4(to + half[1], pbw__load4(item + 1));
    pbw__store4(to + half[2], pbw__load4(item + 2));
    pbw__store4(to + half[3], pbw__load4(item + 3));
}

/* Sorts a list of `count` simplices, four at a time; all: `count` rounded up to a multiple of four.  Lanes past the
   end get the highest key and are written to sorted[0]. */
PBW__SIMD_INLINE void pbw__sort_list_simd(const pbw__item *item, pbw_index begin, unsigned count, unsigned all,
                                          pbw__item *sorted)
{
    const __m256i sign = _mm256_set1_epi64x((int64_t)((uint64_t)1 << 63));
    const __m256i highest = _mm256_set1_epi64x((int64_t)(~(uint64_t)0 >> 1)), lane = _mm256_setr_epi64x(0, 1, 2, 3);
    const __m256i real = _mm256_cmpgt_epi64(_mm256_set1_epi64x((int64_t)count - (int64_t)all + 4), lane);
    __m256i keys[PBW__SHORT / 4];
    int64_t key[PBW__SHORT];
    unsigned i, j;
    item += begin;
    for (j = 0; j < all; j += 4) {
        keys[j / 4] = _mm256_xor_si256(pbw__keys4(item + j), sign);
        if (j + 4 == all) {                          /* by singles: -funsigned-char spoils gcc 12's blend of bytes */
            keys[j / 4] = (__m256i)_mm256_blendv_ps((__m256)highest, (__m256)keys[j / 4], (__m256)real);
        }
        _mm256_storeu_si256((__m256i *)(void *)(key + j), keys[j / 4]);
    }
    for (j = 0; j < all; j += 4) {
        __m256i position = _mm256_set1_epi64x((int64_t)begin + 1);
        for (i = 0; i < all; i += 4) {
            position = _mm256_sub_epi64(position, _mm256_cmpgt_epi64(keys[j / 4], _mm256_set1_epi64x(key[i])));
            position = _mm256_sub_epi64(position, _mm256_cmpgt_epi64(keys[j / 4], _mm256_set1_epi64x(key[i + 1])));
            position = _mm256_sub_epi64(position, _mm256_cmpgt_epi64(keys[j / 4], _mm256_set1_epi64x(key[i + 2])));
            position = _mm256_sub_epi64(position, _mm256_cmpgt_epi64(keys[j / 4], _mm256_set1_epi64x(key[i + 3])));
        }
        pbw__put4(item + j, j + 4 == all ? _mm256_and_si256(position, real) : position, sorted);
    }
}

/* In the plane lists are short and keys ascend from list to list.  Sorts `count` simplices of lists of at most
   reach+1 without their borders: each is compared with the `reach` before it and behind it.  The comparisons are
   signed: ranks are below PBW__POINT_LIMIT, 2^31. */
PBW__SIMD_INLINE void pbw__sort_lists2_simd(const pbw__item *item, pbw_index count, pbw_index reach,
                                            pbw__item *sorted)
{
    int64_t key[PBW__REACH + PBW__LISTS * (PBW__REACH + 1) + 4 + PBW__REACH], *here = key + PBW__REACH;
    pbw_index i, k;
    memset(key, 0, PBW__REACH * sizeof(int64_t));
    for (i = 0; i < count; i += 4) {
        _mm256_storeu_si256((__m256i *)(void *)(here + i), pbw__keys4(item + i));
    }
    for (i = 0; i < PBW__REACH + 4; i++) {
        here[count + i] = (int64_t)(~(uint64_t)0 >> 1);
    }
    for (i = 0; i < count; i += 4, here += 4) {      /* the surplus is overwritten by the next lists */
        const __m256i keys = _mm256_loadu_si256((const __m256i *)(const void *)here);
        __m256i position = _mm256_add_epi64(_mm256_set1_epi64x((int64_t)i), _mm256_setr_epi64x(0, 1, 2, 3));
        for (k = 1; k <= reach; k++) {
            const __m256i before = _mm256_loadu_si256((const __m256i *)(const void *)(here - k));
            const __m256i behind = _mm256_loadu_si256((const __m256i *)(const void *)(here + k));
            position = _mm256_add_epi64(position, _mm256_cmpgt_epi64(before, keys));
            position = _mm256_sub_epi64(position, _mm256_cmpgt_epi64(keys, behind));
        }
        pbw__put4(item + i, position, sorted);
    }
}

/* pbw__sort_lists by vectors.  Groups lists by length first, as lengths are unpredictable. */
PBW__SIMD static void pbw__sort_lists_simd(pbw__item *item, const pbw_index *end, unsigned lists,
                                           pbw_index begin, pbw__item *sorted, int dim)
{
    pbw_index by_fours[PBW__SHORT / 4 + 2][PBW__LISTS][2], from = begin, longest = 1;
    unsigned n[PBW__SHORT / 4 + 2], fours, i, l;
    for (l = 0; l < lists && dim == 2; from = end[l++]) {
        longest = end[l] - from > longest ? end[l] - from : longest;
    }
    if (dim == 2 && longest <= PBW__REACH + 1) {
        pbw__sort_lists2_simd(item + begin, end[lists - 1] - begin, longest - 1, sorted + begin + 1);
        return;
    }
    memset(n, 0, sizeof(n));
    for (l = 0; l < lists; begin = end[l++]) {
        unsigned count = end[l] - begin;
        fours = count <= PBW__SHORT ? (count + 3) / 4 : PBW__SHORT / 4 + 1;
        by_fours[fours][n[fours]][0] = begin;
        by_fours[fours][n[fours]++][1] = count;
    }
    for (fours = 1; fours <= PBW__SHORT / 4 + 1; fours++) {
        for (i = 0; i < n[fours]; i++) {
            const pbw_index *list = by_fours[fours][i];
            if (fours > PBW__SHORT / 4) {
                pbw__sort_hub(item + list[0], list[1], sorted + 1 + list[0]);
            } else if (fours == 1) {
                pbw__sort_list_simd(item, list[0], list[1], 4, sorted);
            } else if (fours == 2) {
                pbw__sort_list_simd(item, list[0], list[1], 8, sorted);
            } else if (fours == 3) {
                pbw__sort_list_simd(item, list[0], list[1], 12, sorted);
            } else {
                pbw__sort_list_simd(item, list[0], list[1], 4 * fours, sorted);
            }
        }
    }
}
#endif

/* Sorts the lists of a region, which end at end[0] .. end[lists-1]. */
PBW__INLINE void pbw__sort_region(const pbw__emission *emission, pbw__item *item, const pbw_index *end, size_t lists,
                                  pbw__item *sorted)
{
    pbw_index begin = 0;
    size_t r;
    for (r = 0; r < lists && !emission->any_order; r += PBW__LISTS) {
        const unsigned n = lists - r < PBW__LISTS ? (unsigned)(lists - r) : PBW__LISTS;
#ifdef PBW__AVX2
        if (emission->simd) {
            pbw__sort_lists_simd(item, end + r, n, begin, sorted, emission->dim);
        } else
#endif
        {
            pbw__sort_lists(item, end + r, n, begin, sorted);
        }
        begin = end[r + n - 1];
    }
}

/* ---- pass 2: numbers
   A task numbers the lists of a share of the regions, from the last list to the first, and stores the number of each
   simplex for all of its corners: the number stored last for a vertex is that of its first simplex.  The numbers
   replace the lengths of lists in `head`: a simplex is in the list of its lowest corner, and the lists of its other
   corners were read before.  Numbers for vertices of later shares go to `first`. */

/* Lists the slots of the chains of `count` regions, chain by chain.  Follows all chains in step, so that their cache
   misses overlap. */
PBW__INLINE void pbw__emit_follow(const pbw__emission *emission, size_t region, unsigned count, const size_t *length,
                                  pbw_index *slot)
{
    const pbw_index *number = emission->number, *corner = emission->corner;
    pbw_index next[PBW__CHAINS], *to[PBW__CHAINS];
    size_t left[PBW__CHAINS], steps, last, k;
    unsigned chains, i, j;
    for (i = chains = 0; i < count; slot += length[i++]) {
        next[chains] = emission->chain[region + i];
        to[chains] = slot;
        left[chains] = length[i];
        chains += length[i] > 0;
    }
    last = pbw__emit_start(emission, region, PBW__CHAINS);
    for (k = pbw__emit_start(emission, region, 2 * PBW__CHAINS); k < last; k += 16) {
        PBW__PREFETCH(number + k);                   /* the chains of the next regions go through there mostly */
    }
    while (chains > 0) {
        for (steps = left[0], i = 1; i < chains; i++) {
            steps = left[i] < steps ? left[i] : steps;
        }
        for (k = 0; k < steps; k++) {
            for (i = 0; i < chains; i++) {
                pbw_index t = next[i];
                to[i][k] = t;
                next[i] = number[t];
                PBW__PREFETCH(corner + 4 * (size_t)t);
            }
        }
        for (i = j = 0; i < chains; i++) {
            next[j] = next[i];
            to[j] = to[i] + steps;
            left[j] = left[i] - steps;
            j += left[j] > 0;
        }
        chains = j;
    }
}

PBW__INLINE void pbw__emit_first(pbw_index *head, pbw_index *first, pbw_index vertex, pbw_index position,
                                 pbw_index later)
{
    if (PBW__LIKELY(later == PBW_NONE || vertex < later)) {
        head[vertex] = position;
    } else {
        pbw_index old = PBW__LOAD(first += vertex);
        while (position < old && !PBW__CAS(first, &old, position)) {
        }
    }
}

/* A task's buffers: the slots of some chains; the lists of a region, unsorted and sorted. */
typedef struct pbw__buffers {
    pbw_index *slot;
    pbw__item *item, *sorted;
    size_t slot_capacity, item_capacity;
    pbw_index position;                              /* one past the last that is still to be given */
} pbw__buffers;

/* Numbers the simplices of a region, in `count` slots.  later: the first rank of later shares, or PBW_NONE. */
PBW__INLINE void pbw__emit_region(const pbw__emission *emission, pbw__buffers *buffers, size_t region,
                                  const pbw_index *slot, size_t count, pbw_index later)
{
    size_t ranks = pbw__emit_ranks(emission, region), lists = pbw__emit_ranks(emission, region + 1) - ranks, r;
    pbw_index *head = emission->head, *end = head + ranks, *first = emission->first, *number = emission->number;
    pbw__item *item = buffers->item;
    pbw_index begin = 0, position = buffers->position;
    buffers->position -= (pbw_index)count;
    for (r = 0; r < lists; r++) {
        pbw_index length = end[r];
        end[r] = begin;
        begin += length;
    }
#ifdef PBW__AVX2
    if (emission->simd) {
        pbw__fill_lists_simd(emission, slot, count, item);
    } else
#endif
    {
        PBW__BY_DIM(emission->dim, pbw__fill_lists_of, emission->corner, slot, count, head, item);
    }
    pbw__sort_region(emission, item, end, lists, buffers->sorted);
    item = emission->any_order ? item : buffers->sorted + 1;
    for (r = lists; r-- > 0; ) {
        begin = r > 0 ? end[r - 1] : 0;              /* PBW_NONE if empty, branchless */
        end[r] = (buffers->position + begin) | (0 - (pbw_index)(begin == end[r]));
    }
    for (item += count; count > 0; count--) {
        item--;
        position--;
        number[item->simplex] = position;
        pbw__emit_first(head, first, (pbw_index)(item->key >> 32), position, later);
        pbw__emit_first(head, first, (pbw_index)item->key, position, later);
        pbw__emit_first(head, first, item->last, position, later);
    }
}

static void pbw__emit_pass2(void *arg, int task)
{
    pbw__emission *emission = (pbw__emission *)arg;
    pbw_memory *memory = &emission->context->memory;
    size_t regions = emission->store->region_count, least = pbw__share(regions, task, emission->tasks);
    size_t region = pbw__share(regions, task + 1, emission->tasks);
    const pbw_index later = region < regions ? (pbw_index)pbw__emit_ranks(emission, region) : PBW_NONE;
    pbw__buffers buffers = { NULL, NULL, NULL, 0, 0, (pbw_index)emission->task[task].end };
    while (region > least && !pbw__report(emission->context, 0.5 - 0.25 * (double)region / (double)regions)) {
        unsigned count = region - least < PBW__CHAINS ? (unsigned)(region - least) : PBW__CHAINS, i;
        size_t length[PBW__CHAINS], sum = 0, longest = 0;
        region -= count;
        for (i = 0; i < count; i++) {
            size_t ranks = pbw__emit_ranks(emission, region + i);
            length[i] = pbw__emit_count(emission->head + ranks, pbw__emit_ranks(emission, region + i + 1) - ranks);
            sum += length[i];
            longest = length[i] > longest ? length[i] : longest;
        }
        longest += 4;                                /* for sorted[0], and the surplus of the last four */
        if ((sum >= buffers.slot_capacity
             && !pbw_memory_fit(memory, &buffers.slot, &buffers.slot_capacity, sum + 1, sizeof(pbw_index)))
            || (2 * longest > buffers.item_capacity
                && !pbw_memory_fit(memory, &buffers.item, &buffers.item_capacity, 2 * longest,
                                      sizeof(pbw__item)))) {
            PBW__STORE(&emission->failed, 1);
            break;
        }
        buffers.sorted = buffers.item + longest;
        pbw__emit_follow(emission, region, count, length, buffers.slot);
        for (i = count; i-- > 0; ) {
            const pbw_index *slot = buffers.slot + (sum -= length[i]);
            if (later == PBW_NONE) {                 /* compiled without comparisons with it */
                pbw__emit_region(emission, &buffers, region + i, slot, length[i], PBW_NONE);
            } else {
                pbw__emit_region(emission, &buffers, region + i, slot, length[i], later);
            }
        }
    }
    pbw__release(memory, buffers.slot, buffers.slot_capacity, sizeof(pbw_index));
    pbw__release(memory, buffers.item, buffers.item_capacity, sizeof(pbw__item));
}
/* ------------------------------------------------------------------------------------------------------
   >>output       From the store's simplices to the caller's arrays, in place.
   In: the positions of >>number.  Out: simplices and neighbours in canonical order, with the caller's ids; the first
   simplex of each point; the points; their numbers along the curve.

   The store's arrays become the caller's: a copy beside them would be the peak of the memory.  Other arrays use
   blocks that the build no longer needs, as new pages cost more: `head` that of the marks, if there are any; `first`
   and `number`, then the points and `incident`, that of the records; `canonical` that of `id`.  Held at most: of a
   slot its simplex and `number`, 36 bytes, and of a vertex `id` and `head`, 8 (12 with several tasks); all are needed
   from pass 2 to pass 3.

   Pass 3 writes each simplex in canonical form, with ids for ranks and positions for slots, from its slot to its
   position.  Slots are read in order, and most positions lie before the slots, among those already read, because
   slots are left over where simplices were deleted.  Where there are more simplices than slots in regions, positions
   lie behind the slots, which are read from the last position on to the first.  A simplex is set aside if its
   position is still to be read; pass 4 writes these.  Tasks take the slots by chunks.  A chunk's flag in chunk_done,
   stored with release order and loaded with acquire order, says that the chunk was read.
   ------------------------------------------------------------------------------------------------------ */
#define PBW__CHUNK ((size_t)1 << 12)                 /* the largest */
#define PBW__APART PBW__SMALLER(3072)                /* slots, at most, that are written to new arrays: many
                                                        would be set aside */

/* Large chunks are better: the start of a chunk is not prefetched, and near slots have positions in the same cache
   lines, which tasks would share.  But a simplex is set aside if its position lies in a chunk in progress, and of
   points uniform in space positions lag behind the slots by only 1/64 of those read.  So chunks are smaller if all
   that threads have in progress would be more than 1/256 of the slots; and small if one task has few points, where
   setting aside costs more. */
PBW__INLINE int pbw__chunk_bits(int dim, int tasks, int threads, size_t slots)
{
    const int least = (int)PBW__SMALLER(10);
    int bits = tasks == 1 && slots >> 20 == 0 ? dim + 6 : dim == 3 ? 12 : 10;
    while (bits > least && (size_t)threads << bits > slots / 256) {
        bits--;
    }
    return bits;
}

/* Returns whether the slots where a position lies have been read; the array has `entries` entries a slot. */
PBW__INLINE int pbw__emit_read(const pbw__emission *emission, size_t position, size_t entries, int dim)
{
    size_t from = position * ((size_t)dim + 1), first = from / entries >> emission->chunk_bits;
    size_t last = (from + (size_t)dim) / entries >> emission->chunk_bits;
    return PBW__LOAD_ACQUIRE(emission->chunk_done + first) != 0
        && (first == last || PBW__LOAD_ACQUIRE(emission->chunk_done + last) != 0);
}

/* Returns whether a position is free: its corners and links have been read; wide links are 8 entries a slot. */
PBW__INLINE int pbw__emit_free(const pbw__emission *emission, const pbw__aside *aside, size_t position, int dim)
{
    return PBW__LIKELY(position - aside->free_from < aside->free_count)
        || (pbw__emit_read(emission, position, 4, dim)
            && (sizeof(pbw__link) == sizeof(pbw_index) || pbw__emit_read(emission, position, 8, dim)));
}

PBW__INLINE void pbw__emit_write(const pbw__emission *emission, const pbw__emitted *simplex, int dim)
{
    size_t corners = (size_t)dim + 1;
    memcpy(emission->to_corner + corners * simplex->position, simplex->corner, corners * sizeof(pbw_index));
    if (emission->link != NULL) {
        memcpy(emission->to_link + corners * simplex->position, simplex->neighbor, corners * sizeof(pbw_index));
    }
}

/* Writes the simplices in slots from..end-1 to their positions, or sets them aside. */
PBW__INLINE void pbw__emit_slots_of(const pbw__emission *emission, size_t from, size_t end, pbw__aside *aside,
                                    int dim)
{
    const pbw_index *number = emission->number;
    size_t t;
    for (t = from; t < end; t++) {
        const pbw_index *v = emission->corner + 4 * t;
        pbw__emitted simplex;
        unsigned order, k;
        if (number[t] == PBW_NONE) {
            continue;
        }
        simplex.position = number[t];
        order = emission->packed ? PBW__IN_ORDER : pbw__canonical_order(v, dim);
        for (k = 0; k <= (unsigned)dim; k++) {
            const pbw_index corner = v[order >> 2 * k & 3];
            simplex.corner[k] = emission->packed ? corner : emission->id[corner];
        }
        for (k = 0; k <= (unsigned)dim && emission->link != NULL; k++) {
            const pbw__link link = emission->link[4 * t + (order >> 2 * k & 3)];
            const pbw_index next = number[link >> 2];
            simplex.neighbor[k] = emission->packed ? 4 * next + (pbw_index)(link & 3) : next;
        }
        if (pbw__emit_free(emission, aside, simplex.position, dim)) {
            pbw__emit_write(emission, &simplex, dim);
        } else {
            aside->simplex[aside->count++] = simplex;
        }
    }
}

#ifdef PBW__AVX2
/* Stores a vector in dim+1 entries. */
PBW__SIMD_INLINE void pbw__emit_entries(pbw_index *to, pbw__i4 x, int dim)
{
    if (dim == 3) {
        pbw__store4(to, x);
    } else {
        _mm_storel_epi64((__m128i *)(void *)to, (__m128i)x);
        to[2] = (pbw_index)_mm_extract_epi32((__m128i)x, 2);
    }
}

/* Lists the slots from..end-1 that have a number; returns how many.  Branchless. */
PBW__SIMD_INLINE size_t pbw__emit_used(const pbw_index *number, size_t from, size_t end, pbw_index *slot)
{
    const pbw__i4 lanes = { 0, 1, 2, 3 };
    pbw__i4 slots = pbw__splat_i((int32_t)from) + lanes;
    size_t count = 0;
    for (; from + 4 <= end; from += 4, slots += 4) {
        const pbw__i4 none = pbw__load4(number + from) == -1;    /* PBW_NONE */
        const unsigned used = 15u ^ (unsigned)_mm_movemask_ps((__m128)none);
        pbw__store4(slot + count, pbw__shuffle4(slots, pbw__front[used]));
        count += pbw__count4(used);
    }
    for (; from < end; from++) {
        slot[count] = (pbw_index)from;
        count += number[from] != PBW_NONE;
    }
    return count;
}

/* pbw__emit_slots_of by vectors.  links: 0: none; 1: numbers of neighbours; PBW__PACKED: links, and corners as they
   are. */
#define PBW__PACKED 2
PBW__SIMD_INLINE void pbw__emit_slots_simd_of(const pbw__emission *emission, size_t from, size_t end,
                                              pbw__aside *aside, int links, int dim)
{
    const pbw_index *number = emission->number, *id = emission->id;
    const pbw__link *link = emission->link;
    pbw_index *to_corner = emission->to_corner, *to_link = emission->to_link, slot[PBW__CHUNK + PBW__SOON];
    const pbw_index *corner = emission->corner;
    const size_t corners = (size_t)dim + 1, used = pbw__emit_used(number, from, end, slot);
    const pbw__aside free = *aside;
    size_t count = aside->count, i, n;
    for (i = 0; i < PBW__SOON && used > 0; i++) {
        slot[used + i] = slot[used - 1];
    }
    for (n = 0; n < used; n++) {
        const size_t t = slot[n], soon = slot[n + PBW__SOON];
        const pbw_index *v = corner + 4 * t, position = number[t];
        pbw__i4 lanes, ids, neighbors = { 0, 0, 0, 0 };
        if (n % 4 == 0) {                            /* slots in a cache line */
            PBW__PREFETCH_STREAM(corner, 4 * t, 4 * emission->slot_count);
            if (links) {
                PBW__PREFETCH_STREAM(link, 4 * t, 4 * emission->slot_count);
            }
        }
        PBW__PREFETCH_TO_WRITE(to_corner + corners * number[soon]);
        if (links) {
            const pbw__link *l = link + 4 * t;
            PBW__PREFETCH_TO_WRITE(to_link + corners * number[soon]);
            for (i = 0; i < corners && dim == 3; i++) {      /* in the plane most are near */
                PBW__PREFETCH(number + (link[4 * soon + i] >> 2));
            }
            neighbors = (pbw__i4)_mm_setr_epi32((int)number[l[0] >> 2], (int)number[l[1] >> 2],
                                                (int)number[l[2] >> 2], dim == 3 ? (int)number[l[3] >> 2] : 0);
        }
        if (links == PBW__PACKED) {
            ids = pbw__load4(v);
            neighbors = neighbors << 2 | (pbw__load4((const pbw_index *)(const void *)(link + 4 * t)) & 3);
        } else {
            lanes = pbw__canonical_lanes(pbw__load4(v), dim);
            ids = (pbw__i4)_mm_setr_epi32((int)id[v[0]], (int)id[v[1]], (int)id[v[2]], dim == 3 ? (int)id[v[3]] : 0);
            ids = pbw__permute4(ids, lanes);
            neighbors = pbw__permute4(neighbors, lanes);
        }
        if (pbw__emit_free(emission, &free, position, dim)) {
            pbw__emit_entries(to_corner + corners * position, ids, dim);
            if (links) {
                pbw__emit_entries(to_link + corners * position, neighbors, dim);
            }
        } else {
            pbw__emitted *simplex = free.simplex + count++;
            simplex->position = position;
            pbw__store4(simplex->corner, ids);
            pbw__store4(simplex->neighbor, neighbors);
        }
    }
    aside->count = count;
}

PBW__SIMD static void pbw__emit_slots_simd(const pbw__emission *emission, size_t from, size_t end, pbw__aside *aside)
{
    if (emission->packed) {
        pbw__emit_slots_simd_of(emission, from, end, aside, PBW__PACKED, 3);
    } else if (emission->link != NULL) {
        PBW__BY_DIM(emission->dim, pbw__emit_slots_simd_of, emission, from, end, aside, 1);
    } else {
        PBW__BY_DIM(emission->dim, pbw__emit_slots_simd_of, emission, from, end, aside, 0);
    }
}
#endif

static void pbw__emit_slots(const pbw__emission *emission, size_t from, size_t end, pbw__aside *aside)
{
#ifdef PBW__AVX2
    if (emission->simd) {
        pbw__emit_slots_simd(emission, from, end, aside);
        return;
    }
#endif
    PBW__BY_DIM(emission->dim, pbw__emit_slots_of, emission, from, end, aside);
}

/* Writes the simplices set aside if their positions are free. */
PBW__INLINE void pbw__emit_aside(const pbw__emission *emission, pbw__aside *aside, int dim)
{
    size_t i;
    for (i = aside->count; i-- > 0; ) {
        pbw__emitted *simplex = aside->simplex + i;
        if (pbw__emit_free(emission, aside, simplex->position, dim)) {
            pbw__emit_write(emission, simplex, dim);
            *simplex = aside->simplex[--aside->count];
        }
    }
}

/* Makes room for the simplices of a chunk; tries those set aside again when there are an eighth and a chunk more. */
static int pbw__emit_reserve(pbw__emission *emission, pbw__aside *aside)
{
    const size_t most = (size_t)1 << emission->chunk_bits;
    const size_t chunk = emission->slot_count < most ? emission->slot_count : most;
    size_t wanted;
    if (aside->capacity - aside->count < chunk) {
        PBW__BY_DIM(emission->dim, pbw__emit_aside, emission, aside);
        wanted = aside->count + aside->count / 8 + chunk;
        if (wanted > aside->capacity
            && !pbw_memory_fit(&emission->context->memory, &aside->simplex, &aside->capacity, wanted,
                                  sizeof(pbw__emitted))) {
            PBW__STORE(&emission->failed, 1);
            return 0;
        }
    }
    return 1;
}

static void pbw__emit_pass3(void *arg, int task)
{
    pbw__emission *emission = (pbw__emission *)arg;
    const size_t size = (size_t)1 << emission->chunk_bits, corners = (size_t)emission->dim + 1;
    const size_t chunks = (emission->slot_count + size - 1) / size, simplices = emission->simplex_count;
    /* The first `turned` chunks are read backwards.  With wide links none are: simplices fill half of their room. */
    const int ahead = simplices > emission->store->region_slots && sizeof(pbw__link) == sizeof(pbw_index);
    const size_t turned = ahead ? (simplices + size - 1) / size : 0;
    size_t next, done = 0;
    pbw__aside aside = { NULL, 0, 0, 0, 0 };         /* on the stack: no false sharing with other tasks */
    while ((next = PBW__ADD(&emission->chunk, 1)) < chunks && !PBW__LOAD(&emission->failed)
           && !pbw__report(emission->context, 0.5 + 0.45 * (double)next / (double)chunks)) {
        size_t chunk = next < turned ? turned - 1 - next : next, from = chunk * size, end = from + size;
        while (done < next
               && PBW__LOAD_ACQUIRE(emission->chunk_done + (done < turned ? turned - 1 - done : done)) != 0) {
            done++;
        }
        aside.free_from = done < turned ? ((turned - done) * size * 4 + corners - 1) / corners : 0;
        aside.free_count = (done < turned ? turned : done) * size * 4 / corners;
        aside.free_count = aside.free_count > aside.free_from ? aside.free_count - aside.free_from : 0;
        if (emission->apart) {
            aside.free_from = 0;
            aside.free_count = simplices;
        } else if (!pbw__emit_reserve(emission, &aside)) {
            break;
        }
        pbw__emit_slots(emission, from, end < emission->slot_count ? end : emission->slot_count, &aside);
        PBW__STORE_RELEASE(emission->chunk_done + chunk, 1);
    }
    emission->task[task].aside = aside;
}

static void pbw__emit_pass4(void *arg, int task)
{
    pbw__emission *emission = (pbw__emission *)arg;
    pbw__aside *aside = &emission->task[task].aside;
    if (!PBW__LOAD(&emission->failed) && !pbw__report(emission->context, 0.95)) {
        aside->free_from = 0;
        aside->free_count = emission->simplex_count;
        PBW__BY_DIM(emission->dim, pbw__emit_aside, emission, aside);
    }
    pbw__release(&emission->context->memory, aside->simplex, aside->capacity, sizeof(pbw__emitted));
}

/* Stores the first simplex of each vertex, by the caller's ids. */
static pbw_status pbw__emit_pass5(void *arg, size_t from, size_t to)
{
    pbw__emission *emission = (pbw__emission *)arg;
    size_t v = from + 1, end = to + 1, visible = 0;
    for (; v < end; v++) {
        const pbw_index first = emission->first != NULL && emission->first[v] < emission->head[v] ? emission->first[v]
                                                                                                 : emission->head[v];
        PBW__PREFETCH_STREAM(emission->head, v, end);
        PBW__PREFETCH_STREAM(emission->id, v, end);
        PBW__PREFETCH_TO_WRITE(emission->incident + emission->id[v + PBW__SOON < end ? v + PBW__SOON : v]);
        emission->incident[emission->id[v]] = first;
        visible += first != PBW_NONE;
    }
    (void)PBW__ADD(&emission->visible, visible);
    return PBW_OK;
}

static pbw_status pbw__emit_status(const pbw__emission *emission)
{
    return emission->failed ? PBW_ERROR_MEMORY : PBW__LOAD(&emission->context->cancelled) ? PBW_CANCELLED : PBW_OK;
}

/* Chooses the arrays to write to: the store's or new ones.  Returns 0 if memory is short. */
static int pbw__emit_begin(pbw__emission *emission)
{
    const size_t entries = emission->simplex_count * ((size_t)emission->dim + 1);
    emission->to_corner = emission->corner;
    emission->to_link = (pbw_index *)(void *)emission->link;
    if (emission->apart) {
        emission->to_corner = (pbw_index *)pbw__allocate_large(emission->context, entries, sizeof(pbw_index));
    }
    if (emission->links_apart && emission->link != NULL) {
        emission->to_link = (pbw_index *)pbw__allocate_large(emission->context, entries, sizeof(pbw_index));
    }
    emission->failed = emission->to_corner == NULL || (emission->to_link == NULL && emission->link != NULL);
    return !emission->failed;
}

/* Counts ghosts, or numbers them. */
static void pbw__emit_ghosts(void *arg, int task)
{
    const pbw__emission *emission = (const pbw__emission *)arg;
    const size_t to = pbw__share(emission->slot_count, task + 1, emission->tasks);
    size_t t, next = emission->task[task].ghosts;
    for (t = pbw__share(emission->slot_count, task, emission->tasks); t < to; t++) {
        if (emission->number[t] == PBW_NONE && emission->corner[4 * t] != PBW_NONE) {
            emission->number[t] = emission->placing ? (pbw_index)next : PBW_NONE;
            next++;
        }
    }
    emission->task[task].ghosts = next;
}

static pbw_status pbw__emit(pbw__emission *emission)
{
    pbw__context *context = emission->context;
    size_t sum = 0;
    int tasks = emission->tasks, task;
    pbw__for(context, tasks, pbw__emit_pass1, emission);
    if (tasks > 1) {
        pbw__for(context, tasks, pbw__emit_others, emission);
    }
    pbw__for(context, tasks, pbw__emit_counts, emission);
    for (task = 0; task < tasks; task++) {
        emission->task[task].end = sum += emission->task[task].end;
    }
    emission->simplex_count = sum;
    if (pbw__emit_status(emission) != PBW_OK) {
        return pbw__emit_status(emission);
    }
    pbw__for(context, tasks, pbw__emit_pass2, emission);
    for (; emission->packed && emission->placing < 2; emission->placing++) {
        if (tasks > 1 || emission->placing) {
            pbw__for(context, tasks, pbw__emit_ghosts, emission);
        }
        for (task = 0; task < tasks && !emission->placing; task++) {
            const size_t here = emission->task[task].ghosts;
            emission->task[task].ghosts = sum;
            sum += here;
        }
        emission->simplex_count = emission->task[tasks - 1].ghosts;
    }
    if (pbw__emit_status(emission) != PBW_OK || !pbw__emit_begin(emission)) {
        return pbw__emit_status(emission);
    }
    pbw__for(context, tasks, pbw__emit_pass3, emission);
    pbw__for(context, tasks, pbw__emit_pass4, emission);
    return pbw__emit_status(emission);
}

/* The sizes of a mesh's arrays; mesh->memory points at it. */
typedef struct pbw__owned {
    pbw_memory memory;
    size_t simplices, neighbors, incident, canonical, original, points, weights;        /* items in each array; 0: not
                                                                                           the mesh's own */
} pbw__owned;

/* The mesh's copy of the input, in the caller's order or that of mesh->original. */
typedef struct pbw__copying {
    const pbw__input *input;
    const pbw_index *original;
    double *points, *weights;
} pbw__copying;

static pbw_status pbw__copy_points(void *arg, size_t i, size_t end)
{
    const pbw__copying *copying = (const pbw__copying *)arg;
    const pbw__input *input = copying->input;
    const size_t dim = (size_t)input->dim;
    const int packed = !input->is_float && input->stride == dim * sizeof(double) && input->weights == NULL
        && copying->original == NULL;
    size_t k;
    for (k = i * dim; packed && k < end * dim; k++) {
        double x;
        memcpy(&x, input->points + k * sizeof(double), sizeof(double));          /* of any alignment */
        copying->points[k] = x + 0.0;                /* no -0.0 */
    }
    for (; !packed && i < end; i++) {
        double record[4];
        pbw__fetch(input, copying->original != NULL ? copying->original[i] : i, record);
        memcpy(copying->points + i * dim, record, dim * sizeof(double));
        if (copying->weights != NULL) {
            copying->weights[i] = record[dim];
        }
    }
    return PBW_OK;
}

/* Copies the points to the start of a block of `room` doubles, the mesh's from now on, or to a new block if that is
   NULL. */
static pbw_status pbw__keep_points(pbw__context *context, const pbw__input *input, pbw__owned *owned, pbw_mesh *mesh,
                                   double *block, size_t room)
{
    pbw__copying copying = { input, mesh->original, NULL, NULL };
    if (input->borrow) {
        mesh->points = (const double *)(const void *)input->points;
        mesh->weights = (const double *)(const void *)input->weights;
        return PBW_OK;
    }
    owned->points = block != NULL ? room : input->count * (size_t)input->dim;
    mesh->points = copying.points = block != NULL ? block
                 : (double *)pbw__allocate_large(context, owned->points, sizeof(double));
    if (input->weights != NULL) {
        owned->weights = input->count;
        mesh->weights = copying.weights = (double *)pbw__allocate_large(context, input->count, sizeof(double));
    }
    if (copying.points == NULL || (input->weights != NULL && copying.weights == NULL)) {
        return PBW_ERROR_MEMORY;
    }
    return pbw__for_range(context, input->count, 8192, 0.0, pbw__copy_points, &copying);
}

/* Makes mesh->incident in a block of its size, or in a new one if that is NULL; fills it with PBW_NONE if `none`. */
static pbw_index *pbw__make_incident(pbw__context *context, pbw__owned *owned, pbw_mesh *mesh, int none, void *block)
{
    pbw_index *incident = (pbw_index *)(block != NULL ? block
                        : pbw__allocate_large(context, mesh->point_count, sizeof(pbw_index)));
    mesh->incident = incident;
    owned->incident = block != NULL ? 0 : mesh->point_count;
    if (incident != NULL && none) {
        pbw__set_bytes(context, incident, 0xff, mesh->point_count * sizeof(pbw_index));
    }
    return incident;
}

/* Sets the arrays of an emission: `head` in the block of the marks, if there are any, then `first`, if there are
   several tasks, and `number` in that of the records. */
static void pbw__emit_arrays(pbw__emission *emission, const pbw__store *store, const pbw__vertices *vertices)
{
    const size_t ranks = emission->vertex_count + 1;
    pbw_index *at = (pbw_index *)(void *)vertices->record;
    emission->head = store->mark != NULL ? (pbw_index *)(void *)store->mark : at;
    emission->first = emission->tasks > 1 ? at + (store->mark == NULL ? ranks : 0) : NULL;
    emission->number = at + emission->rank_entries;
}

/* Makes the arrays of an emission in blocks that the build no longer needs: their pages exist. */
static int pbw__emit_room(pbw__emission *emission, pbw__store *store, pbw__vertices *vertices)
{
    pbw_memory *memory = &emission->context->memory;
    const size_t chunks = (emission->slot_count >> emission->chunk_bits) + 1, ranks = emission->vertex_count + 1;
    size_t room;
    emission->rank_entries = ranks * ((emission->tasks > 1 ? 1u : 0u) + (store->mark == NULL ? 1u : 0u));
    room = ((emission->slot_count + emission->rank_entries) * sizeof(pbw_index) + chunks) / sizeof(double) + 1;
    if (store->mark != NULL && !PBW__RESIZE(memory, store, mark, ranks * sizeof(pbw_index))) {
        return 0;
    }
    if (room > vertices->room) {                     /* its contents are no longer needed */
        pbw__release(memory, vertices->record, vertices->room, sizeof(double));
        vertices->record = (double *)pbw__allocate_large(emission->context, room, sizeof(double));
        vertices->room = vertices->record != NULL ? room : 0;
    }
    if (vertices->record == NULL) {
        return 0;
    }
    pbw__emit_arrays(emission, store, vertices);
    emission->chunk_done = (unsigned char *)(emission->number + emission->slot_count);
    memset(emission->chunk_done, 0, chunks);
    return 1;
}

/* Allocates what the tasks of an emission need and runs it. */
static pbw_status pbw__emit_all(pbw__emission *emission, pbw__store *store, pbw__vertices *vertices)
{
    pbw_memory *memory = &emission->context->memory;
    const size_t tasks = (size_t)emission->tasks;
    pbw_status status = PBW_ERROR_MEMORY;
    emission->task = tasks > 1 ? (pbw__emitting *)pbw__allocate(memory, tasks, sizeof(pbw__emitting))
                               : &emission->one_task;
    if (emission->task != NULL && pbw__emit_room(emission, store, vertices)) {
        memset(emission->task, 0, tasks * sizeof(pbw__emitting));
        status = pbw__emit(emission);
    }
    if (tasks > 1) {
        pbw__release(memory, emission->task, tasks, sizeof(pbw__emitting));
    }
    return status;
}

/* Gives back what an emission no longer needs: the ends of the store's arrays, and `number`, which lies last in the
   block of the records, except for what the mesh will have there: the points and, behind them, `incident`.  Without
   points, `incident` has a block of its own.  Returns 0 if memory is short. */
static int pbw__emit_cut(pbw__emission *emission, pbw__store *store, pbw__vertices *vertices, pbw__owned *owned,
                         pbw_mesh *mesh, size_t points)
{
    pbw_memory *memory = &emission->context->memory;
    const size_t entries = emission->simplex_count * ((size_t)emission->dim + 1);
    const size_t firsts = emission->rank_entries / 2 + 1, kept = points > firsts ? points : firsts;      /* doubles */
    const size_t behind = points > 0 ? vertices->point_count / 2 + 1 : 0;
    size_t links = store->link_capacity * (sizeof(pbw__link) / sizeof(pbw_index));
    mesh->simplices = emission->apart ? emission->to_corner : NULL;
    mesh->neighbors = emission->links_apart ? emission->to_link : NULL;
    mesh->simplex_count = emission->simplex_count;
    owned->simplices = owned->neighbors = entries;
    if (!emission->apart) {
        if (!pbw_memory_fit(memory, &store->corner, &store->corner_capacity, entries, sizeof(pbw_index))) {
            return 0;
        }
        mesh->simplices = store->corner;
        store->corner = NULL;
    }
    if (!emission->links_apart && store->link != NULL) {
        if (!pbw_memory_fit(memory, &store->link, &links, entries, sizeof(pbw_index))) {
            return 0;
        }
        mesh->neighbors = (pbw_index *)(void *)store->link;
        store->link = NULL;
    }
    if (!pbw_memory_fit(memory, &vertices->record, &vertices->room, kept + behind, sizeof(double))) {
        return 0;
    }
    pbw__emit_arrays(emission, store, vertices);
    emission->incident = pbw__make_incident(emission->context, owned, mesh, vertices->count < mesh->point_count,
                                            behind > 0 ? vertices->record + kept : NULL);
    return emission->incident != NULL;
}

static void pbw__emission_start(pbw__emission *emission, pbw__context *context, const pbw__store *store,
                                const pbw__vertices *vertices)
{
    memset(emission, 0, sizeof(*emission));
    emission->context = context;
    emission->store = store;
    emission->corner = store->corner;
    emission->link = store->link;
    emission->slot_count = store->count;
    emission->vertex_count = vertices->count;
    emission->dim = vertices->dim;
#ifdef PBW__AVX2
    emission->simd = pbw__simd_works();
#endif
    emission->id = vertices->id;
    emission->chain = store->hint;
    emission->tasks = pbw__tasks(context, vertices->count, 2048);
    emission->apart = store->lent == 2 || (emission->tasks == 1 && emission->slot_count <= PBW__APART);
    emission->links_apart = emission->apart || store->lent != 0;
    emission->chunk_bits = pbw__chunk_bits(emission->dim, emission->tasks, context->threads, store->count);
}

/* Turns the store's triangulation into the mesh's arrays. */
static pbw_status pbw__output(pbw__context *context, pbw__store *store, pbw__vertices *vertices, unsigned flags,
                              pbw__owned *owned, pbw_mesh *mesh)
{
    pbw_memory *memory = &context->memory;
    const size_t corners = (size_t)vertices->dim + 1;
    const size_t points = (flags & PBW_BORROW) == 0 ? vertices->point_count * (size_t)vertices->dim : 0;
    pbw__emission emission;
    pbw_status status;
    if (store->capacity - store->count > store->capacity / 1024 + 64     /* not of few points */
        && pbw__store_reserve(context, store, store->count) != PBW_OK) {     /* gives the rest of the tail back */
        return PBW_ERROR_MEMORY;
    }
    if ((flags & PBW_NO_NEIGHBORS) != 0) {
        pbw__release(memory, store->link, store->link_capacity, sizeof(pbw__link));
        store->link = NULL;
    }
    pbw__emission_start(&emission, context, store, vertices);
    emission.any_order = (flags & PBW_ANY_ORDER) != 0;
    status = pbw__emit_all(&emission, store, vertices);
    if (status == PBW_OK) {
        status = !pbw__emit_cut(&emission, store, vertices, owned, mesh, points) ? PBW_ERROR_MEMORY
               : pbw__for_range(context, emission.vertex_count, 16384, 0.0, pbw__emit_pass5, &emission);
    } else {
        if (emission.apart) {
            pbw__release(memory, emission.to_corner, corners * emission.simplex_count, sizeof(pbw_index));
        }
        if (emission.links_apart) {
            pbw__release(memory, emission.to_link, corners * emission.simplex_count, sizeof(pbw_index));
        }
    }
    mesh->hidden_count = vertices->count - emission.visible;
    return status;
}

/* New numbers along the curve, for pbw_order and PBW_CURVE_ORDER: each vertex is followed by its duplicates, in
   ascending order.  Fills `original` (new number -> the caller's), and turns `id` and `canonical` of the vertices
   into new numbers. */
typedef struct pbw__numbering {
    pbw__vertices *vertices;
    pbw_index *original, *next;                      /* next: per canonical point, the first free number of its
                                                        group; unused if there are no duplicates */
} pbw__numbering;

static pbw_status pbw__number_range(void *arg, size_t from, size_t to)
{
    const pbw__numbering *numbering = (const pbw__numbering *)arg;
    pbw_index *id = numbering->vertices->id + 1;
    for (; from < to; from++) {
        numbering->original[from] = id[from];
        id[from] = (pbw_index)from;
    }
    return PBW_OK;
}

static void pbw__number_groups(pbw__numbering *numbering)
{
    pbw__vertices *vertices = numbering->vertices;
    pbw_index *next = numbering->next, *original = numbering->original, *canonical = vertices->canonical;
    size_t i, r, free_number = 0;
    memset(next, 0, vertices->point_count * sizeof(pbw_index));
    for (i = 0; i < vertices->point_count; i++) {
        next[canonical[i]]++;
    }
    for (r = 1; r <= vertices->count; r++) {
        const pbw_index point = vertices->id[r];
        const size_t points = next[point];
        original[free_number] = point;
        vertices->id[r] = (pbw_index)free_number;
        next[point] = (pbw_index)free_number + 1;
        free_number += points;
    }
    for (i = 0; i < vertices->point_count; i++) {
        if (canonical[i] != i) {
            original[next[canonical[i]]++] = (pbw_index)i;
        }
    }
    for (r = 1; r <= vertices->count; r++) {         /* groups lie between the numbers of successive vertices */
        const size_t first = vertices->id[r], end = r < vertices->count ? vertices->id[r + 1] : vertices->point_count;
        for (i = first; i < end; i++) {
            canonical[i] = (pbw_index)first;
        }
    }
}

static pbw_status pbw__number_along_curve(pbw__context *context, pbw__vertices *vertices, pbw_index *original)
{
    pbw__numbering numbering;
    pbw_status status;
    numbering.vertices = vertices;
    numbering.original = original;
    if (vertices->duplicate_count == 0) {
        return pbw__for_range(context, vertices->count, 8192, 0.0, pbw__number_range, &numbering);
    }
    status = pbw__make_canonical(context, vertices, NULL);
    if (status != PBW_OK) {
        return status;
    }
    numbering.next = (pbw_index *)pbw__allocate(&context->memory, vertices->point_count, sizeof(pbw_index));
    if (numbering.next == NULL) {
        return PBW_ERROR_MEMORY;
    }
    pbw__number_groups(&numbering);
    pbw__release(&context->memory, numbering.next, vertices->point_count, sizeof(pbw_index));
    return PBW_OK;
}
/* ------------------------------------------------------------------------------------------------------
   >>hash         One number for a triangulation.
   In: a mesh.  Out: 64 bits that depend on the set of its simplices, each a set of points, on the set of its
   points that are no duplicates, hidden ones included, and on the dimension; a point is its coordinates and its
   weight, 0 where there are no weights.  So all weights 0 and no weights give one number.  Sums make it
   independent of order; the mixing before each sum makes equal sums of different sets a matter of chance.
   ------------------------------------------------------------------------------------------------------ */
static uint64_t pbw__hash_point(const pbw_mesh *mesh, size_t p)
{
    static const double none = 0.0;
    uint64_t place = pbw__hash_doubles((uint64_t)mesh->dim, mesh->points + p * (size_t)mesh->dim, mesh->dim);
    return pbw__hash_doubles(place, mesh->weights != NULL ? mesh->weights + p : &none, 1);
}

typedef struct pbw__hashing {
    const pbw_mesh *mesh;
    const unsigned char *chosen;                     /* NULL: all */
    uint64_t *point;                                 /* a number for each; NULL: no memory, they are made each time */
    uint64_t sum;                                    /* ranges add theirs, in any order */
} pbw__hashing;

static pbw_status pbw__hash_points(void *arg, size_t p, size_t end)
{
    pbw__hashing *hashing = (pbw__hashing *)arg;
    uint64_t sum = 0;
    for (; p < end; p++) {
        if (hashing->mesh->canonical[p] == p) {      /* no corner is another */
            const uint64_t point = pbw__hash_point(hashing->mesh, p);
            if (hashing->point != NULL) {
                hashing->point[p] = point;
            }
            sum += hashing->chosen == NULL || hashing->chosen[p] ? point : 0;        /* mixed well enough */
        }
    }
    (void)PBW__ADD(&hashing->sum, sum);
    return PBW_OK;
}

static pbw_status pbw__hash_simplices(void *arg, size_t s, size_t end)
{
    pbw__hashing *hashing = (pbw__hashing *)arg;
    const size_t corners = (size_t)hashing->mesh->dim + 1;
    uint64_t sum = 0;
    size_t k;
    for (; s < end; s++) {
        const pbw_index *corner = hashing->mesh->simplices + s * corners;
        uint64_t points = 0;
        if (hashing->chosen != NULL && !hashing->chosen[s]) {
            continue;
        }
        for (k = 0; k < corners; k++) {
            if (corner[k] >= hashing->mesh->point_count || hashing->mesh->canonical[corner[k]] != corner[k]) {
                return PBW_ERROR_ARGUMENT;
            }
            points += hashing->point != NULL ? hashing->point[corner[k]] : pbw__hash_point(hashing->mesh, corner[k]);
        }
        sum += pbw_mix(points);
    }
    (void)PBW__ADD(&hashing->sum, sum);
    return PBW_OK;
}

PBWDEF pbw_status pbw_hash_parts(const pbw_mesh *mesh, const unsigned char *points, const unsigned char *simplices,
                                 const pbw_options *options, pbw_hash_sums *sums)
{
    pbw__context context;
    pbw__hashing hashing = { mesh, points, NULL, 0 };
    pbw_status status;
    if (mesh == NULL || sums == NULL || (mesh->dim != 2 && mesh->dim != 3)
        || (mesh->point_count > 0 && (mesh->points == NULL || mesh->canonical == NULL))
        || (mesh->simplex_count > 0 && mesh->simplices == NULL)) {
        return PBW_ERROR_ARGUMENT;
    }
    status = pbw__begin_call(&context, options, mesh->point_count);
    status = status == PBW_OK && pbw__enter_stage(&context, PBW_STAGE_WORK) ? PBW_CANCELLED : status;
    if (status == PBW_OK) {
        hashing.point = (uint64_t *)pbw__allocate(&context.memory, mesh->point_count, sizeof(uint64_t));
        status = pbw__for_range(&context, mesh->point_count, 16384, 0.1, pbw__hash_points, &hashing);
    }
    sums->points = hashing.sum;
    hashing.chosen = simplices;
    hashing.sum = 0;
    if (status == PBW_OK) {
        status = pbw__for_range(&context, mesh->simplex_count, 16384, 1.0, pbw__hash_simplices, &hashing);
    }
    sums->simplices = hashing.sum;
    pbw__release(&context.memory, hashing.point, mesh->point_count, sizeof(uint64_t));
    return pbw__end_call(&context, status);
}

PBWDEF uint64_t pbw_hash_of(const pbw_hash_sums *sums)
{
    return sums == NULL ? 0 : pbw_mix(sums->points + pbw_mix(sums->simplices));
}

PBWDEF uint64_t pbw_hash(const pbw_mesh *mesh, const pbw_options *options)
{
    pbw_hash_sums sums;
    const int hashed = mesh != NULL && mesh->point_count > 0
                    && pbw_hash_parts(mesh, NULL, NULL, options, &sums) == PBW_OK;
    return hashed ? pbw_hash_of(&sums) : 0;
}
/* ------------------------------------------------------------------------------------------------------
   >>tools        For companion headers: sorting, signs, centres, loops on threads.
   In: the caller's arrays.  Out: the library's threads, its sorts and its exact numbers, as public functions; what
   must be inlined is in >>interface, what allocates in >>memory.
   ------------------------------------------------------------------------------------------------------ */
/* ---- sorting
   Keys of 64 bits, by their low halves first, then by their high ones: words of half a key and, below it, the
   index. */
typedef struct pbw__key_halves {
    const uint64_t *keys;
    pbw_index *order;
    uint64_t *words;
    uint64_t differing;                              /* bits in which some key differs from the first */
    int half;                                        /* 0: low; order is not read, but that of the indices */
} pbw__key_halves;

static pbw_status pbw__fill_halves(void *arg, size_t from, size_t to)
{
    pbw__key_halves *halves = (pbw__key_halves *)arg;
    uint64_t differing = 0, old;
    for (; from < to; from++) {
        const uint64_t index = halves->half ? halves->order[from] : from, key = halves->keys[index];
        differing |= key ^ halves->keys[0];
        halves->words[from] = (halves->half ? key >> 32 : key & 0xffffffff) << 32 | index;
    }
    old = PBW__LOAD(&halves->differing);
    while ((differing & ~old) != 0 && !PBW__CAS(&halves->differing, &old, old | differing)) {
    }
    return PBW_OK;
}

static pbw_status pbw__read_order(void *arg, size_t from, size_t to)
{
    const pbw__key_halves *halves = (const pbw__key_halves *)arg;
    for (; from < to; from++) {
        halves->order[from] = (pbw_index)halves->words[from];
    }
    return PBW_OK;
}

static pbw_status pbw__sort_halves(pbw__context *context, pbw__key_halves *halves, pbw__sorting *sorting,
                                   uint32_t *start)
{
    pbw_status status = PBW_OK;
    for (halves->half = 0; halves->half < 2 && status == PBW_OK; halves->half++) {
        const double done = 0.5 * halves->half;
        halves->words = sorting->a;
        status = pbw__for_range(context, sorting->count, 65536, done + 0.1, pbw__fill_halves, halves);
        if (status == PBW_OK && (halves->differing >> 32 * halves->half & 0xffffffff) != 0) {
            sorting->start = start;
            sorting->tasks = context->threads;
            halves->words = start == NULL ? pbw__sort_keys(sorting, 32, 32) : pbw__sort_by(sorting, 32, 32);
            status = halves->words == NULL ? PBW_CANCELLED : PBW_OK;
        }
        if (status == PBW_OK) {
            status = pbw__for_range(context, sorting->count, 65536, done + 0.5, pbw__read_order, halves);
        }
    }
    return status;
}

PBWDEF pbw_status pbw_sort(const uint64_t *keys, size_t count, const pbw_options *options, pbw_index *order)
{
    pbw__context context;
    pbw__sorting sorting;
    pbw__key_halves halves = { keys, order, NULL, 0, 0 };
    pbw_status status;
    if (count > 0 && (keys == NULL || order == NULL)) {
        return PBW_ERROR_ARGUMENT;
    }
    if (count > PBW_NONE) {
        return PBW_ERROR_TOO_LARGE;
    }
    status = pbw__begin_call(&context, options, count);
    status = status == PBW_OK && pbw__enter_stage(&context, PBW_STAGE_WORK) ? PBW_CANCELLED : status;
    if (status == PBW_OK && count > 0) {
        const size_t starts = context.threads > 1 ? ((size_t)context.threads + 1) * PBW__DIGITS : 0;
        uint64_t *a = (uint64_t *)pbw__allocate(&context.memory, count, sizeof(uint64_t));
        uint64_t *b = (uint64_t *)pbw__allocate(&context.memory, count, sizeof(uint64_t));
        uint32_t *start = starts > 0 ? (uint32_t *)pbw__allocate(&context.memory, starts, sizeof(uint32_t)) : NULL;
        sorting.context = &context;
        sorting.a = a;
        sorting.b = b;
        sorting.count = count;
        status = a == NULL || b == NULL || (starts > 0 && start == NULL) ? PBW_ERROR_MEMORY
               : pbw__sort_halves(&context, &halves, &sorting, start);
        pbw__release(&context.memory, a, count, sizeof(uint64_t));
        pbw__release(&context.memory, b, count, sizeof(uint64_t));
        pbw__release(&context.memory, start, starts, sizeof(uint32_t));
    }
    return pbw__end_call(&context, status);
}

PBWDEF uint64_t pbw_sort_key(double x)
{
    const uint64_t top = (uint64_t)1 << 63, bits = pbw__bits(x) << 1 == 0 ? 0 : pbw__bits(x);
    return bits & top ? ~bits : bits | top;
}

/* ---- numbers
   The filter is a sum in doubles.  Its error and that of the sum of absolute values are each at most count 2^-52
   times the latter, to first order and in any rounding mode (Higham 2002, "Accuracy and Stability of Numerical
   Algorithms", section 3.1), and the smallest normal number for each product that underflows: 2^-50 covers both. */
PBWDEF int pbw_sign_of_products(const double *a, const double *b, int count)
{
    pbw__digit pool[2][PBW__POOL / 4], factor[PBW__POOL / 4], one_digit = 1;
    const pbw__integer one = { &one_digit, 0, 1 };
    pbw__integer sum = { pool[0], 0, 0 };
    double value = 0.0, size = 0.0;
    const int low[2] = { pbw__exact_unit(a, count, 1024), pbw__exact_unit(b, count, 1024) };
    int i;
    for (i = 0; i < count; i++) {
        const double product = a[i] * b[i];
        value += product;
        size += pbw__abs(product);
    }
    size = count * (9e-16 * size + DBL_MIN);
    if (value > size || value < -size) {             /* not with infinities or NaN */
        return value > 0 ? 1 : -1;
    }
    for (i = 0; i < count; i++) {
        pbw__digit *top = factor, *room = pool[i % 2 == 0];
        const pbw__integer x = pbw__exact_difference(a[i], 0.0, low[0], &top);
        const pbw__integer y = pbw__exact_difference(b[i], 0.0, low[1], &top);
        const pbw__product term[2] = { { { &sum, &one }, 0 }, { { &x, &y }, 0 } };
        sum = pbw__exact_sum(term, 2, &room);
    }
    return pbw__exact_sign(&sum);
}

/* With B, C, D the other corners relative to the first one, a, and B2 = |B|^2 - (w_b - w_a), and so on,
       centre = (B2 CxD + C2 DxB + D2 BxC) / (2 B.CxD). */
PBW__DEVICE PBWDEF int pbw_centre(int dim, const double *const *corner, const double *weight, double *centre)
{
    const pbw_pair zero = { 0.0, 0.0 };
    pbw_pair row[3][3], height[3], minor[3][3], sum[3] = { { 0.0, 0.0 }, { 0.0, 0.0 }, { 0.0, 0.0 } }, det = zero;
    double largest = 0.0, least;
    int i, k;
    for (i = 0; i < dim; i++) {
        double square = 0.0;
        height[i] = weight != NULL ? pbw_two_sum(weight[0], -weight[i + 1]) : zero;
        for (k = 0; k < dim; k++) {
            row[i][k] = pbw_two_sum(corner[i + 1][k], -corner[0][k]);
            height[i] = pbw_pair_plus(height[i], pbw_pair_times(row[i][k], row[i][k]));
            square += PBW__TIMES(row[i][k].head, row[i][k].head);
        }
        largest = pbw__max(largest, square);
    }
    least = 1e-30 * (dim == 3 ? largest * pbw__square_root(largest) : largest);
    for (i = 0; i < dim; i++) {
        if (dim == 3) {                              /* the cross product of the other two rows */
            const pbw_pair *p = row[(i + 1) % 3], *q = row[(i + 2) % 3];
            for (k = 0; k < 3; k++) {
                minor[i][k] = pbw_pair_minor(p[(k + 1) % 3], p[(k + 2) % 3], q[(k + 1) % 3], q[(k + 2) % 3]);
            }
        } else {                                     /* the other row, turned */
            const double sign = i == 0 ? 1.0 : -1.0;
            minor[i][0] = pbw__pair_scaled(row[1 - i][1], sign);
            minor[i][1] = pbw__pair_scaled(row[1 - i][0], -sign);
        }
        for (k = 0; k < dim; k++) {
            sum[k] = pbw_pair_plus(sum[k], pbw_pair_times(height[i], minor[i][k]));
        }
    }
    for (k = 0; k < dim; k++) {
        det = pbw_pair_plus(det, pbw_pair_times(row[0][k], minor[0][k]));
    }
    for (k = 0; k < dim; k++) {                      /* positive, but perhaps below what pairs resolve */
        centre[k] = sum[k].head / (2.0 * pbw__max(det.head, least));
    }
    return det.head > 1e16 * least;
}

/* ---- threads and order */
PBWDEF pbw_status pbw_for(const pbw_options *options, size_t count, size_t grain, pbw_body *body, void *arg)
{
    const size_t blocks = grain > 0 ? count / grain + (count % grain != 0) : 0, most = (size_t)-1 / 8192;
    pbw__context context;
    pbw_status status;
    if (body == NULL || grain == 0) {
        return PBW_ERROR_ARGUMENT;
    }
    if (blocks > most / 64) {
        return PBW_ERROR_TOO_LARGE;
    }
    /* 8192: begin_call starts a thread for so many points; a range is worth one. */
    status = pbw__begin_call(&context, options, blocks * 8192);
    if (status == PBW_OK) {
        status = pbw__enter_stage(&context, PBW_STAGE_WORK) ? PBW_CANCELLED
               : pbw__for_range(&context, count, grain, 1.0, body, arg);
    }
    return pbw__end_call(&context, status);
}

PBWDEF pbw_status pbw_order(int dim, const double *points, size_t count, const pbw_options *options, pbw_index *order)
{
    pbw__context context;
    pbw__vertices vertices;
    pbw__input input = pbw__input_of(dim, 0, points, NULL, count);
    pbw_status status = pbw__begin_call(&context, options, count);
    if (status == PBW_OK) {
        status = order == NULL && count > 0 ? PBW_ERROR_ARGUMENT : pbw__input_check(&input, &context.options);
    }
    if (status == PBW_OK && count > 0) {
        status = pbw__enter_stage(&context, PBW_STAGE_ORDER) ? PBW_CANCELLED
               : pbw__order(&context, &input, &vertices);
        if (status == PBW_OK) {
            status = pbw__number_along_curve(&context, &vertices, order);
            pbw__vertices_free(&context, &vertices);
        }
    }
    return pbw__end_call(&context, status);
}

/* ------------------------------------------------------------------------------------------------------
   >>seam         What pbw_check.h, pbw_query.h and pbw_live.h use of the rooms above.
   In: the private names of this file.  Out: those that these may use, with their rooms; of a struct, its members.
   Holds: the list is what they use, tests/seam.sh compares; who changes what a name in it means raises PBW__SEAM.

   They are compiled behind this file, in one source file, and refuse another number.

     PBW__DEVICE                                                                        check            interface
     pbw__hash_doubles                                                                  check live       platform
     PBW__INLINE PBW__NOINLINE                                                          check query live platform
     pbw__fp pbw__fp_enter pbw__fp_is_exact pbw__fp_leave                               live             platform
     PBW__ADD PBW__CAS                                                                  query live       platform
     PBW__PREFETCH_TO_WRITE PBW__STORE PBW__STORE_RELEASE PBW__THREADS                  live             platform
     pbw__max_abs pbw__square_root                                                      query            platform
     pbw__abs PBW__AVX2 PBW__BY_DIM pbw__hash_entry PBW__LIKELY PBW__LOAD pbw__max      query live       platform
     PBW__PREFETCH PBW__SIMD pbw__squared PBW__UNLIKELY                                 query live       platform
     pbw__abs4 pbw__blend pbw__columns pbw__det2 pbw__first pbw__fma pbw__fnma          live             lanes
     pbw__half pbw__join pbw__min_lane PBW__OPERATION                                   live             lanes
     pbw__first_lanes pbw__i4 pbw__l4 pbw__mask pbw__or4 pbw__order4 pbw__order4_of     query            lanes
     pbw__reorder                                                                       query            lanes
     pbw__and4 pbw__at_least pbw__count4 pbw__d4 pbw__equal pbw__four pbw__greater      query live       lanes
     pbw__load4d pbw__max4 pbw__signs PBW__SIMD_INLINE pbw__simd_works pbw__splat       query live       lanes
     pbw__allocate pbw__allocate_large pbw__context pbw__release                        check query live memory
     pbw__block pbw__block_of pbw__populate                                             live             memory
     PBW__RELEASE PBW__RESIZE                                                           query live       memory
     pbw__tasks                                                                         check live       threads
     pbw__begin_call pbw__end_call                                                      check query      threads
     pbw__enter_stage pbw__for_range pbw__report PBW__TICK                              check query live threads
     pbw__context_start pbw__for pbw__set_bytes pbw__set_or_copy pbw__share             live             threads
     pbw__team_stop                                                                     live             threads
     PBW__SMALLER                                                                       query live       threads
     PBW__TEST_PAUSE                                                                    live             threads
     pbw__digit PBW__POOL                                                               check query      exact
     pbw__column PBW__DIGIT_BITS pbw__exact_difference pbw__exact_sign pbw__exact_sum   query            exact
     pbw__exact_unit pbw__integer pbw__power_of_two pbw__product                        query            exact
     pbw__grid_add pbw__grid_close pbw__grid_share pbw__grid_share_reset                check            grid
     pbw__grid                                                                          check query live grid
     pbw__collinear3 pbw__conflict_in PBW__OPEN pbw__orient_in                          check            predicates
     pbw__orient                                                                        check live       predicates
     PBW__CIRCLE_ERROR PBW__EAR_ERROR PBW__ORIENT2_ERROR PBW__ORIENT3_ERROR             live             predicates
     PBW__SPHERE_ERROR PBW__TIME_ERROR PBW__TIME_LEAST                                  live             predicates
     pbw__exponent PBW__FILTER_ORIENT2_ERROR PBW__FILTER_ORIENT3_ERROR                  query            predicates
     pbw__pair_difference pbw__pair_minus pbw__pair_plus pbw__pair_scaled               query            predicates
     pbw__pair_times pbw__power PBW__REACH_ERROR                                        query            predicates
     pbw__conflict pbw__side                                                            query live       predicates
     pbw__box_close pbw__curve pbw__curve_create pbw__hilbert_key                       check            curve
     pbw__box pbw__box_add pbw__box_reset                                               check query      curve
     pbw__index_bits pbw__input_check PBW__POINT_LIMIT                                  live             curve
     pbw__fetch pbw__fetch_soon                                                         query            curve
     pbw__input pbw__input_of                                                           query live       curve
     PBW__DIGITS pbw__sort_by pbw__sorting                                              check live       sort
     pbw__sort_keys                                                                     live             sort
     pbw__same_place                                                                    check live       order
     pbw__make_canonical                                                                live             order
     pbw__order pbw__vertices pbw__vertices_free                                        query live       order
     PBW__DEFERRED pbw__facet_corners PBW__GHOST PBW__GROW pbw__kernel                  live             mesh
     pbw__kernel_attach pbw__kernel_free pbw__link PBW__NOBODY pbw__ownership           live             mesh
     pbw__simplex_conflict PBW__SIMPLEX_LIMIT pbw__slots pbw__store                     live             mesh
     pbw__grow_lists pbw__leave_cavity pbw__region_bits pbw__store_free                 live             slots
     pbw__store_reserve pbw__take_slots                                                 live             slots
     pbw__exit pbw__point4 pbw__point4_of pbw__rows4 pbw__rows4_of pbw__walk_start      live             walk
     pbw__dot4                                                                          live             cavity3
     pbw__build_all pbw__kernel_create pbw__scratch_create                              live             build
     pbw__is_ours pbw__owns_zone                                                        live             parallel
     pbw__canonical_order pbw__emission PBW__SOON                                       live             number
     pbw__emission_start pbw__emit_all pbw__make_incident pbw__output pbw__owned        live             output
     pbw__has_arrays PBW__SEAM_BEGIN PBW__SEAM_END                                      check query live seam
   ------------------------------------------------------------------------------------------------------ */
#define PBW__SEAM 1

/* Above and below the code of such a header: no contraction, and no warnings of MSVC, as >>platform has it here. */
#if defined(__clang__) && (defined(__x86_64__) || defined(__i386__))
#define PBW__SEAM_BEGIN _Pragma("float_control(push)") _Pragma("STDC FP_CONTRACT OFF")
#define PBW__SEAM_END _Pragma("float_control(pop)")
#elif defined(__clang__)
#define PBW__SEAM_BEGIN _Pragma("STDC FP_CONTRACT OFF")
#define PBW__SEAM_END _Pragma("STDC FP_CONTRACT DEFAULT")
#elif defined(__GNUC__) && defined(_WIN32)
#define PBW__SEAM_BEGIN PBW_CONTRACTION_OFF _Pragma("GCC optimize(\"no-ipa-ra\")")
#define PBW__SEAM_END PBW_CONTRACTION_ON
#elif defined(_MSC_VER)
#define PBW__SEAM_BEGIN __pragma(fp_contract(off)) __pragma(warning(push)) __pragma(warning(disable : 4244 4996))
#define PBW__SEAM_END __pragma(warning(pop))
#else
#define PBW__SEAM_BEGIN PBW_CONTRACTION_OFF
#define PBW__SEAM_END PBW_CONTRACTION_ON
#endif

/* Returns whether a mesh has a dimension, and the arrays that its counts ask for. */
PBW__INLINE int pbw__has_arrays(const pbw_mesh *mesh, int with_neighbors)
{
    return mesh != NULL && (mesh->dim == 2 || mesh->dim == 3)
        && (mesh->point_count == 0 || (mesh->points != NULL && mesh->incident != NULL && mesh->canonical != NULL))
        && (mesh->simplex_count == 0 || (mesh->simplices != NULL && (!with_neighbors || mesh->neighbors != NULL)));
}

/* ------------------------------------------------------------------------------------------------------
   >>api          The front door: argument checks, defaults, the stages in order, status texts.
   In: what the caller passes.  Out: a mesh or a status; nothing is left allocated after a failure.
   ------------------------------------------------------------------------------------------------------ */
PBWDEF const char *pbw_status_string(pbw_status status)
{
    switch (status) {
    case PBW_OK: return "success";
    case PBW_DEGENERATE: return "the points do not span the space: there are no simplices";
    case PBW_CANCELLED: return "cancelled by the progress callback";
    case PBW_ERROR_ARGUMENT: return "bad argument: NULL, dimension, stride, thread count or flag";
    case PBW_ERROR_NOT_FINITE: return "a coordinate or weight is not a finite number";
    case PBW_ERROR_TOO_LARGE: return "too many points or simplices for the index type";
    case PBW_ERROR_MEMORY: return "out of memory, or over the memory limit";
    case PBW_ERROR_THREAD: return "no thread could be started";
    case PBW_ERROR_FP_MODE: return "floating-point arithmetic is not IEEE 754 double, rounded to nearest";
    case PBW_ERROR_BACKEND: return "the backend failed or does not fit this version";
    }
    return "unknown status";
}

PBWDEF int pbw_version(void)
{
    return PBW_VERSION;
}

PBWDEF void pbw_free(pbw_mesh *mesh)
{
    if (mesh != NULL && mesh->memory != NULL) {
        pbw__owned *owned = (pbw__owned *)mesh->memory;
        pbw_memory memory = owned->memory;
        pbw__release(&memory, (void *)(uintptr_t)mesh->simplices, owned->simplices, sizeof(pbw_index));
        pbw__release(&memory, (void *)(uintptr_t)mesh->neighbors, owned->neighbors, sizeof(pbw_index));
        if (owned->incident > 0) {                   /* else it lies behind the points */
            pbw__release(&memory, (void *)(uintptr_t)mesh->incident, owned->incident, sizeof(pbw_index));
        }
        pbw__release(&memory, (void *)(uintptr_t)mesh->canonical, owned->canonical, sizeof(pbw_index));
        pbw__release(&memory, (void *)(uintptr_t)mesh->original, owned->original, sizeof(pbw_index));
        if (owned->points > 0) {
            pbw__release(&memory, (void *)(uintptr_t)mesh->points, owned->points, sizeof(double));
            pbw__release(&memory, (void *)(uintptr_t)mesh->weights, owned->weights, sizeof(double));
        }
        pbw__release(&memory, owned, 1, sizeof(pbw__owned));
    }
    if (mesh != NULL) {
        memset(mesh, 0, sizeof(*mesh));
    }
}

/* Notes the time that a stage took, and reports its end if it succeeded. */
static pbw_status pbw__leave_stage(pbw__context *context, pbw_status status, double *start, double *seconds)
{
    double now = pbw__seconds();
    *seconds = now - *start;
    *start = now;
    return (status == PBW_OK || status == PBW_DEGENERATE) && pbw__report(context, 1.0) ? PBW_CANCELLED : status;
}

/* Makes mesh->original: see pbw__number_along_curve. */
static pbw_status pbw__make_original(pbw__context *context, pbw__vertices *vertices, pbw__owned *owned,
                                     pbw_mesh *mesh)
{
    pbw_index *original = (pbw_index *)pbw__allocate_large(context, vertices->point_count, sizeof(pbw_index));
    mesh->original = original;
    owned->original = vertices->point_count;
    return original != NULL ? pbw__number_along_curve(context, vertices, original) : PBW_ERROR_MEMORY;
}

/* Hands `canonical` to the mesh, made in the block of `id` unless there is one. */
static pbw_status pbw__hand_over_canonical(pbw__context *context, pbw__vertices *vertices, pbw__owned *owned,
                                           pbw_mesh *mesh)
{
    pbw_status status = PBW_OK;
    if (vertices->canonical == NULL) {
        size_t room = vertices->point_count + 1;
        if (!pbw_memory_fit(&context->memory, &vertices->id, &room, vertices->point_count, sizeof(pbw_index))) {
            return PBW_ERROR_MEMORY;
        }
        status = pbw__make_canonical(context, vertices, vertices->id);
        vertices->id = NULL;
    }
    mesh->canonical = vertices->canonical;
    owned->canonical = vertices->point_count;
    vertices->canonical = NULL;
    return status;
}

static pbw_status pbw__build_on_cpu(pbw__context *context, const pbw__input *input, unsigned flags, pbw_mesh *mesh)
{
    pbw_memory *memory = &context->memory;
    pbw__owned *owned = (pbw__owned *)pbw__allocate(memory, 1, sizeof(pbw__owned));
    pbw__vertices vertices;
    pbw__store store;
    double start = pbw__seconds();
    pbw_status status;

    if (owned == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(owned, 0, sizeof(*owned));
    memset(&vertices, 0, sizeof(vertices));
    memset(&store, 0, sizeof(store));
    store.plain = input->dim == 2;
    mesh->memory = owned;
    mesh->dim = input->dim;
    mesh->point_count = input->count;
    if (input->count == 0) {
        owned->memory = *memory;
        return PBW_DEGENERATE;
    }
    status = pbw__enter_stage(context, PBW_STAGE_ORDER) ? PBW_CANCELLED : pbw__order(context, input, &vertices);
    if (status == PBW_OK) {
        mesh->duplicate_count = vertices.duplicate_count;
        status = pbw__leave_stage(context, status, &start, &mesh->statistics.order_seconds);
    }
    if (status == PBW_OK) {
        status = pbw__enter_stage(context, PBW_STAGE_BUILD) ? PBW_CANCELLED
               : pbw__build_all(context, &store, &vertices, &vertices.grid, &mesh->statistics);
        status = pbw__leave_stage(context, status, &start, &mesh->statistics.build_seconds);
        store.plain = 1;                             /* the output uses the block of the marks */
    }
    if ((status == PBW_OK || status == PBW_DEGENERATE) && pbw__enter_stage(context, PBW_STAGE_OUTPUT)) {
        status = PBW_CANCELLED;
    }
    if ((status == PBW_OK || status == PBW_DEGENERATE) && (flags & PBW_CURVE_ORDER) != 0) {
        const pbw_status numbered = pbw__make_original(context, &vertices, owned, mesh);
        status = numbered != PBW_OK ? numbered : status;
    }
    if (status == PBW_OK) {
        status = pbw__output(context, &store, &vertices, flags, owned, mesh);
    } else if (status == PBW_DEGENERATE && pbw__make_incident(context, owned, mesh, 1, NULL) == NULL) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK || status == PBW_DEGENERATE) {
        pbw_status kept = pbw__hand_over_canonical(context, &vertices, owned, mesh);
        kept = kept != PBW_OK ? kept : pbw__keep_points(context, input, owned, mesh, vertices.record, vertices.room);
        vertices.record = mesh->points != NULL && !input->borrow ? NULL : vertices.record;
        status = pbw__leave_stage(context, kept != PBW_OK ? kept : status, &start, &mesh->statistics.output_seconds);
    }
    mesh->statistics.threads = context->threads;
    mesh->statistics.peak_bytes = memory->peak;
    pbw__store_free(memory, &store);
    pbw__vertices_free(context, &vertices);
    pbw__team_stop(context);
    owned->memory = *memory;
    return status;
}

/* ---- backends */
/* What the functions of a job work on. */
typedef struct pbw__dispatch {
    pbw__context *context;
    const pbw__input *input;
    const pbw_options *options;
    pbw__owned *owned;
    pbw_mesh *mesh;
} pbw__dispatch;

/* Allocates the arrays; a backend may call it again with another count. */
static pbw_status pbw__job_reserve(pbw_job *job, size_t simplex_count)
{
    pbw__dispatch *dispatch = (pbw__dispatch *)job->context;
    pbw__owned *owned = dispatch->owned;
    pbw_mesh *mesh = dispatch->mesh;
    pbw_index **array[4];
    size_t *held[4], i;
    pbw__block block[4];
    int blocks = 0;
    pbw_status status = PBW_OK;
    if (simplex_count >= PBW_NONE) {
        return PBW_ERROR_TOO_LARGE;
    }
    array[0] = &job->simplices, held[0] = &owned->simplices;
    array[1] = &job->neighbors, held[1] = &owned->neighbors;
    array[2] = &job->incident, held[2] = &owned->incident;
    array[3] = &job->canonical, held[3] = &owned->canonical;
    for (i = 0; i < 4 && status == PBW_OK; i++) {
        const size_t wanted = i >= 2 ? job->count : simplex_count > 0 ? simplex_count * ((size_t)job->dim + 1) : 1;
        const size_t old = *held[i];
        if (i == 1 && (job->flags & PBW_NO_NEIGHBORS) != 0) {
            continue;
        }
        if (!pbw_memory_fit(&dispatch->context->memory, array[i], held[i], wanted, sizeof(pbw_index))) {
            status = PBW_ERROR_MEMORY;
        }
        block[blocks++] = pbw__block_of(*array[i], old * sizeof(pbw_index), *held[i] * sizeof(pbw_index));
    }
    pbw__populate(dispatch->context, block, blocks);
    mesh->simplex_count = simplex_count;
    mesh->simplices = job->simplices;
    mesh->neighbors = job->neighbors;
    mesh->incident = job->incident;
    mesh->canonical = job->canonical;
    return status;
}

/* Keeps the points.  A backend calls this when it has time, so we also commit pages for about the simplices to come;
   another number costs nothing later, as the default allocator moves pages, not bytes. */
static pbw_status pbw__job_keep(pbw_job *job)
{
    pbw__dispatch *dispatch = (pbw__dispatch *)job->context;
    pbw_status status = pbw__keep_points(dispatch->context, dispatch->input, dispatch->owned, dispatch->mesh,
                                         NULL, 0);
    job->kept_points = dispatch->mesh->points;
    job->kept_weights = dispatch->mesh->weights;
    if (status == PBW_OK && job->simplices == NULL && dispatch->context->memory.resize == pbw__default_resize) {
        (void)pbw__job_reserve(job, job->dim == 3 ? job->count / 5 * 34 : job->count * 2);
    }
    return status;
}

static int pbw__job_report(pbw_job *job, pbw_stage stage, double done)
{
    pbw__context *context = ((pbw__dispatch *)job->context)->context;
    return (stage != context->stage && pbw__enter_stage(context, stage)) || pbw__report(context, done);
}

static void pbw__job_say(pbw_job *job, const char *text)
{
    const pbw_options *options = ((pbw__dispatch *)job->context)->options;
    size_t length = strlen(text);
    if (options->message != NULL && options->message_size > 0) {
        length = length < options->message_size ? length : options->message_size - 1;
        memcpy(options->message, text, length);
        options->message[length] = '\0';
    }
}

/* Renumbers a backend's mesh along the curve, into the arrays that the CPU makes. */
typedef struct pbw__renumbering {
    const pbw_mesh *mesh;
    const pbw_index *original, *old_incident;
    pbw_index *number, *simplices, *incident;
    const double *old_points, *old_weights;
    double *points, *weights;
} pbw__renumbering;

static pbw_status pbw__renumber_points(void *arg, size_t from, size_t to)
{
    const pbw__renumbering *r = (const pbw__renumbering *)arg;
    const size_t dim = (size_t)r->mesh->dim;
    for (; from < to; from++) {
        const size_t old = r->original[from];
        r->number[old] = (pbw_index)from;
        r->incident[from] = r->old_incident[old];
        memcpy(r->points + from * dim, r->old_points + old * dim, dim * sizeof(double));
        if (r->weights != NULL) {
            r->weights[from] = r->old_weights[old];
        }
    }
    return PBW_OK;
}

static pbw_status pbw__renumber_corners(void *arg, size_t from, size_t to)
{
    const pbw__renumbering *r = (const pbw__renumbering *)arg;
    for (; from < to; from++) {
        r->simplices[from] = r->number[r->simplices[from]];
    }
    return PBW_OK;
}

static pbw_status pbw__renumber(pbw__dispatch *dispatch)
{
    pbw__context *context = dispatch->context;
    pbw_memory *memory = &context->memory;
    pbw__owned *owned = dispatch->owned;
    pbw_mesh *mesh = dispatch->mesh;
    const size_t count = mesh->point_count, corners = mesh->simplex_count * ((size_t)mesh->dim + 1);
    pbw__vertices vertices;
    pbw__renumbering r;
    pbw_status status = pbw__order(context, dispatch->input, &vertices);
    if (status != PBW_OK) {
        return status;
    }
    memset(&r, 0, sizeof(r));
    status = pbw__make_original(context, &vertices, owned, mesh);
    if (status == PBW_OK && vertices.canonical == NULL) {
        status = pbw__make_canonical(context, &vertices, NULL);
    }
    r.mesh = mesh;
    r.original = mesh->original;
    r.old_incident = mesh->incident;
    r.old_points = mesh->points;
    r.old_weights = mesh->weights;
    r.simplices = (pbw_index *)(uintptr_t)mesh->simplices;
    r.number = (pbw_index *)pbw__allocate(memory, count, sizeof(pbw_index));
    r.incident = (pbw_index *)pbw__allocate(memory, count, sizeof(pbw_index));
    r.points = (double *)pbw__allocate(memory, owned->points, sizeof(double));
    r.weights = mesh->weights != NULL ? (double *)pbw__allocate(memory, count, sizeof(double)) : NULL;
    if (status == PBW_OK && (r.number == NULL || r.incident == NULL || r.points == NULL
                             || (r.weights == NULL && mesh->weights != NULL))) {
        status = PBW_ERROR_MEMORY;
    }
    if (status == PBW_OK) {
        const pbw_index *canonical = mesh->canonical;
        status = pbw__for_range(context, count, 16384, 0.0, pbw__renumber_points, &r);
        if (status == PBW_OK) {
            status = pbw__for_range(context, corners, 65536, 0.0, pbw__renumber_corners, &r);
        }
        mesh->incident = r.incident;
        mesh->points = r.points;
        mesh->weights = r.weights;
        mesh->canonical = vertices.canonical;
        r.incident = (pbw_index *)(uintptr_t)r.old_incident;
        r.points = (double *)(uintptr_t)r.old_points;
        r.weights = (double *)(uintptr_t)r.old_weights;
        vertices.canonical = (pbw_index *)(uintptr_t)canonical;
    }
    pbw__release(memory, r.number, count, sizeof(pbw_index));
    pbw__release(memory, r.incident, count, sizeof(pbw_index));
    pbw__release(memory, r.points, owned->points, sizeof(double));
    pbw__release(memory, r.weights, count, sizeof(double));
    pbw__vertices_free(context, &vertices);
    return status;
}

/* Runs the backend of the options.  Sets *declined if it leaves the input to the CPU. */
static pbw_status pbw__run_backend(pbw__context *context, const pbw__input *input, const pbw_options *options,
                                   pbw_mesh *mesh, int *declined)
{
    pbw__owned *owned = (pbw__owned *)pbw__allocate(&context->memory, 1, sizeof(pbw__owned));
    pbw__dispatch dispatch = { context, input, options, NULL, mesh };
    pbw_job job;
    double start = pbw__seconds();
    pbw_status status;
    if (owned == NULL) {
        return PBW_ERROR_MEMORY;
    }
    memset(owned, 0, sizeof(*owned));
    mesh->memory = owned;
    mesh->dim = input->dim;
    mesh->point_count = input->count;
    dispatch.owned = owned;
    memset(&job, 0, sizeof(job));
    job.dim = input->dim;
    job.is_float = input->is_float;
    job.threads = options->threads;
    job.flags = options->flags;
    job.count = input->count;
    job.stride = input->stride;
    job.weight_stride = input->weight_stride;
    job.memory_limit = options->memory_limit;
    job.points = input->points;
    job.weights = input->weights;
    job.keep = pbw__job_keep;
    job.reserve = pbw__job_reserve;
    job.report = pbw__job_report;
    job.say = pbw__job_say;
    job.context = &dispatch;
    if (options->backend->version != PBW_VERSION || options->backend->triangulate == NULL) {
        pbw__job_say(&job, "the backend was compiled with another version of pbw.h");
        status = PBW_ERROR_BACKEND;
    } else {
        status = pbw__enter_stage(context, PBW_STAGE_ORDER) ? PBW_CANCELLED
               : options->backend->triangulate(options->backend, &job);
    }
    if (status == PBW_OK && job.kept_points == NULL) {
        status = pbw__job_keep(&job);
    }
    if ((status == PBW_OK || status == PBW_DEGENERATE) && (options->flags & PBW_CURVE_ORDER) != 0) {
        const pbw_status numbered = pbw__renumber(&dispatch);
        status = numbered != PBW_OK ? numbered : status;
    }
    if (status == PBW_OK && (pbw__report(context, 1.0) || pbw__job_report(&job, PBW_STAGE_OUTPUT, 1.0))) {
        status = PBW_CANCELLED;
    }
    pbw__team_stop(context);
    *declined = job.declined;
    mesh->duplicate_count = job.duplicate_count;
    mesh->hidden_count = job.hidden_count;
    mesh->statistics.by_backend = 1;
    mesh->statistics.build_seconds = pbw__seconds() - start;
    mesh->statistics.peak_bytes = context->memory.peak;
    owned->memory = context->memory;
    return status;
}

static pbw_status pbw__triangulate(pbw__input input, const pbw_options *options, pbw_mesh *mesh)
{
    pbw_options defaults;
    pbw__context context;
    pbw__fp fp;
    pbw_status status;
    int on_cpu, declined = 0;
    if (mesh == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(mesh, 0, sizeof(*mesh));
    memset(&defaults, 0, sizeof(defaults));
    options = options != NULL ? options : &defaults;
    status = pbw__input_check(&input, options);
    if (status != PBW_OK) {
        return status;
    }
    if (options->trace != NULL && input.count > 0) {
        memset(options->trace, 0xff, input.count * sizeof(uint32_t));      /* PBW_NONE */
    }
    fp = pbw__fp_enter();
    status = pbw__fp_is_exact() ? PBW_ERROR_BACKEND : PBW_ERROR_FP_MODE;
    for (on_cpu = options->backend == NULL || input.count == 0; status == PBW_ERROR_BACKEND; on_cpu = 1) {
        pbw__context_start(&context, options, input.count);
        if (on_cpu) {
            status = pbw__build_on_cpu(&context, &input, options->flags, mesh);
        } else {
            status = pbw__run_backend(&context, &input, options, mesh, &declined);
            if (status == PBW_ERROR_BACKEND && !declined && (options->flags & PBW_BACKEND_OR_CPU) == 0) {
                break;
            }
            if (status == PBW_ERROR_BACKEND) {
                pbw_free(mesh);
            }
        }
    }
    pbw__fp_leave(fp);
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        pbw_free(mesh);
    }
    return status;
}

PBWDEF pbw_status pbw_triangulate(int dim, const double *points, const double *weights, size_t count,
                                  const pbw_options *options, pbw_mesh *mesh)
{
    return pbw__triangulate(pbw__input_of(dim, 0, points, weights, count), options, mesh);
}

PBWDEF pbw_status pbw_triangulatef(int dim, const float *points, const float *weights, size_t count,
                                   const pbw_options *options, pbw_mesh *mesh)
{
    return pbw__triangulate(pbw__input_of(dim, 1, points, weights, count), options, mesh);
}

#if defined(__clang__) && (defined(__x86_64__) || defined(__i386__))
#pragma float_control(pop)
#elif defined(__clang__)
#pragma STDC FP_CONTRACT DEFAULT                     /* clang 14 has no stack of modes there */
#elif defined(__GNUC__)
#pragma GCC pop_options
#endif
#if defined(PBW__THREADS) && !defined(__GNUC__)
#pragma warning(pop)
#endif
#ifdef _WIN32
#pragma pop_macro("near")
#pragma pop_macro("far")
#pragma pop_macro("small")
#endif

/* ------------------------------------------------------------------------------------------------------
   >>history
   0.2.0   2026-11-28   New: pbw_for, pbw_threads_start, pbw_order, pbw_conflict2, pbw_conflict3, pbw_hash_parts; the
                        base of the companions, pbw_memory to PBW_FACET_CORNER; PBW_CURVE_ORDER and mesh.original,
                        PBW_BORROW; PBW_STAGE_WORK; loops and cells of pbw_cuda.cu, boxes that repeat;
                        pbw_job.memory_limit.
                        Changed: pbw_hash takes options, and is 0 for what is no mesh; arguments are checked before
                        progress is called.
                        Queries are in pbw_query.h, live triangulations in pbw_live.h, pbw_check in pbw_check.h:
                        include these, and beside PBW_IMPLEMENTATION define PBW_QUERY_IMPLEMENTATION,
                        PBW_LIVE_IMPLEMENTATION, PBW_CHECK_IMPLEMENTATION.  Gone: PBW_NO_QUERIES, PBW_NO_LIVE, of
                        the days when pbw.h had both.
   0.1.0   2026-11-21   First version: 2D and 3D, weights, exact, threads, GPU backend; check and hash.
   ------------------------------------------------------------------------------------------------------ */
#endif /* PBW_IMPLEMENTATION */

/* ------------------------------------------------------------------------------------------------------
   >>license      MIT No Attribution

   Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
   documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
   rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to
   permit persons to whom the Software is furnished to do so.

   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO
   THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
   AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT,
   TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
   SOFTWARE.
   ------------------------------------------------------------------------------------------------------ */
