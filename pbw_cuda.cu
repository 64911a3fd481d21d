/* pbw_cuda.cu - the triangulation of pbw.h on an NVIDIA GPU - MIT-0

   Build:  nvcc -O3 -c pbw_cuda.cu        (compute capability 7.0 or later; CUDA 11.7 or later)
   Use:    options.backend = pbw_cuda_backend(0), or pbw_cuda_backend_multi for several devices,
           or pbw_cuda_triangulate for points on the device, or pbw_cuda_loop_step for points that move.

   The result equals that of the CPU byte for byte, because it is a function of the points alone (see CONVENTIONS in
   pbw.h) and every sign that it depends on is exact.

   CERTIFIED LOCAL STARS.  The star of a vertex v is built by inserting points near v into a triangulation of which
   only the simplices around v are kept: those in conflict with the new point are replaced by the fan from the point
   to their border, as in Bowyer-Watson.  When no other point of the input is in conflict with any simplex of the
   star, each of them belongs to the one perturbed triangulation, and together they surround v: the star is certified,
   it is the star of v in the result.  So stars are independent of each other, and need not be repaired or agreed on.
   The result is read off: each simplex is written by its lowest vertex, neighbours are found through the star of the
   lowest vertex of the facet between them.

     first rung    8 lanes a star; candidates from a list of groups of points near v; certified if the spheres of the
                   star lie within the box that the list covers.  About 97 of 100 stars of uniform points.
     second rung   a warp a star; candidates from a search of the box tree for points in conflict with the simplices
                   that the first rung left uncertified.  Hull stars, sparse places, larger stars.  At first by floats
                   and, where they leave it open, doubles; then with exact tests and more room.
     third rung    like the second, with room for 1000 vertices and with the last exact stage of pbw.h.  A handful;
                   the few that reach the cap on their search get a much larger one once.
     the CPU       takes the whole input if a star fits no rung, if the points are few, or if a sample of stars
                   predicts that the CPU is faster: on lines stars are too large, nearly in a plane too flat for
                   floats, and on a common sphere, even a noisy one, each circumsphere passes near all points.
                   Points on the device are then copied to the host, and the arrays back; if the caller names no
                   CPU, the rungs above build them or the call fails.

   Unweighted points in space on surfaces (scans, terrain) have rungs of their own, >>wide, which search another tree.
   They are recognised by a sample of 1024 stars of which the first rung certifies less than half.

   SEVERAL DEVICES.  Stars need no agreement, so each card makes those of its share, a run of the curve, and writes
   its run of the simplices, over its own link to the host.  All put all points into order, a twentieth of the work of
   one, and exchange what numbers the simplices across the borders of the shares (>>cells).  A card holds all points
   and its share of the rest: 90 + 560 / cards bytes a point (2D: 75 + 155 / cards).  So two cards of one kind take
   1.7 times the points of one, and many cards up to the limit of the simplex numbers (600 million points).
   An input of which one card leaves a star to the CPU is left to it as a whole.
   Where two devices can reach each other, each opens its pool to the other, and leaves it so; for a pool that keeps
   60 GB the first call takes half a second longer.

   POINTS THAT MOVE.  A loop has a pool of its own, which keeps what a step frees for the next.  It keeps the mesh of
   the last step too.  A step puts the points into order and, if the duplicates are those of before, tests that mesh
   with the new coordinates (>>check): positive simplices, locally regular facets under the tie rule, a convex hull
   that is covered once, hidden points in conflict with none.  Such a mesh is the triangulation of the new points; the
   order of its simplices depends on the curve, and follows from the new ranks (>>keep).  The first fault ends the
   test, and the stars are built.

   MEMORY.  Device memory is taken from the pool of the current device, as much as options.memory_limit allows; if it
   will not do, which is known before the stars and before the output, the message says the bytes needed and
   available, and under PBW_BACKEND_OR_CPU the CPU takes over.

   CONTENTS
     >>device    types, tiles of lanes, what a call holds
     >>curve     points in the order of the Hilbert curve, duplicates set aside
     >>tree      groups of 8 points, boxes of 32 boxes
     >>sphere    the float form of a conflict test and its bound; the exact test
     >>star      one star: insertion, storing
     >>near      the first rung
     >>far       the second and third rung
     >>wide      the rungs for points on surfaces
     >>cells     simplices, neighbours, incident simplices
     >>check     the exact verdict on a mesh
     >>keep      a mesh whose points have moved, put into the order of the curve again
     >>run       the stages in order
     >>entry     the backend, and the entries for points on the device
*/
#include <cuda_runtime.h>

#define PBW_STATIC
#define PBW_NO_SIMD
#define PBW_IMPLEMENTATION
#define PBW__DEVICE __host__ __device__
#include "pbw.h"

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <stdarg.h>
#include <stdio.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <type_traits>
#include <utility>

#ifndef PBW_CUDA_FEW
#define PBW_CUDA_FEW 1024                            /* fewer points are quicker on the CPU */
#endif
#ifdef PBW_CUDA_TEST
extern "C" {                                         /* tests set these */
#else
namespace {
#endif
int pbw_cuda_by_host = 0;                            /* devices take each other for unreachable */
int pbw_cuda_patient = 0;                            /* no input is declined after a sample */
long pbw_cuda_fail_at = 0;                           /* counts down: the allocation of device memory that fails */
}

namespace {

/* ------------------------------------------------------------------------------------------------------
   >>device       Types, tiles of lanes.
   A tile is 8 or 32 neighbouring lanes of a warp that work on one star.  The tiles of a warp run in lockstep: every
   collective is on the full warp, tiles with nothing to do pass through it.  (Sub-warp masks are legal, but tiles
   then drift apart, and the instruction cache thrashes.)
   ------------------------------------------------------------------------------------------------------ */
const unsigned all_lanes = 0xffffffffu;
const uint32_t none = 0xffffffffu;                   /* no point; as a vertex of a star: the vertex at infinity */
const uint32_t hidden = 0xfffffffeu;                 /* as the place of a star: the vertex has none */

struct alignas(32) record {                          /* as pbw.h keeps them: {x, y, w, 0} or {x, y, z, w} */
    double c[4];
};

/* Of 8 points or 32 boxes, in units of the space, rounded outward; weight: the largest, relative to the heaviest. */
struct alignas(16) box {
    float low[3], high[3], weight, unused;
};

/* Grows a box to hold another. */
__device__ inline void add_box(box &b, const box &other)
{
    for (int k = 0; k < 3; k++) {
        b.low[k] = fminf(b.low[k], other.low[k]);
        b.high[k] = fmaxf(b.high[k], other.high[k]);
    }
    b.weight = fmaxf(b.weight, other.weight);
}

template <typename NODE, int LEVELS> struct tree_of {
    const NODE *level[LEVELS];                       /* level[0]: groups of 8 points */
    uint32_t size[LEVELS];
    int levels;                                      /* level[levels-1] has at most 32 nodes */
};
const int tree_levels = 7;                           /* 8 * 32^6 points are more than an index can number */
typedef tree_of<box, tree_levels> tree;

/* The points in the order of the curve.  A coordinate in units of the space is (x - low) * unit, from 0 to 2; the
   unit is a power of two, so that scaling rounds nothing. */
struct space {
    const record *point;
    const float4 *rough;                             /* the coordinates in units, as floats: where a look will do */
    uint32_t count;
    double low[3], end[3], unit, heaviest;           /* end: the other corner of the box of all points */
    float high[3];                                   /* end in units, relative to low */
    pbw__grid grid;
    double exact_height;                             /* >>sphere: below it doubles are exact; 0 if nowhere */
};

struct queue {                                       /* vertices for the next rung, in no order */
    uint32_t *vertex, *count;                        /* counts of several follow each other */
};

const uint32_t stored_mark = 1u << 31;               /* in a queue: the store holds a star to go on from */

/* The finished stars: a star is a head (triangles << 16 | vertices), its vertices, and its triangles as 3 numbers of
   vertices in 10 bits each (2D: edges, 2 numbers), padded to 16 bytes.  Bit 30 of a triangle is left over from the
   search. */
struct store {
    uint32_t first, end;                             /* the share: vertices whose stars are made here */
    uint32_t *word;
    unsigned long long *used;                        /* units of 16 bytes needed: above capacity if it is too small */
    unsigned long long capacity;
    uint32_t *place;                                 /* of each vertex from first: the unit where its star begins */
    uint32_t *owned;                                 /* likewise: simplices of which it is the lowest vertex */
    const volatile uint32_t *stop;                   /* not 0: the call has failed or is cancelled, nothing counts */
};

template <int T> __device__ inline unsigned tile_ballot(bool value)
{
    unsigned vote = __ballot_sync(all_lanes, value);
    return T == 32 ? vote : vote >> (threadIdx.x & 31 & ~(T - 1)) & ((1u << (T & 31)) - 1);
}

template <int T> __device__ inline unsigned lanes_below()
{
    return (1u << (threadIdx.x & (T - 1))) - 1;
}

template <int T, typename V> __device__ inline V tile_read(V value, int lane)
{
    return __shfl_sync(all_lanes, value, lane, T);
}

template <typename V> __device__ inline void exchange(V &a, V &b)
{
    const V c = a;
    a = b;
    b = c;
}

/* The smallest and the largest value, and the sum, of the lanes of a tile. */
template <int T, typename V> __device__ inline V tile_min(V value)
{
    for (int step = T / 2; step > 0; step /= 2) {
        value = min(value, __shfl_xor_sync(all_lanes, value, step));
    }
    return value;
}

template <int T, typename V> __device__ inline V tile_max(V value)
{
    for (int step = T / 2; step > 0; step /= 2) {
        value = max(value, __shfl_xor_sync(all_lanes, value, step));
    }
    return value;
}

template <int T, typename V> __device__ inline V tile_sum(V value)
{
    for (int step = T / 2; step > 0; step /= 2) {
        value += __shfl_xor_sync(all_lanes, value, step);
    }
    return value;
}

/* The largest value of any tile: the common end of a loop. */
template <int T> __device__ inline int warp_max(int value)
{
    for (int step = T; step < 32; step *= 2) {
        int other = __shfl_xor_sync(all_lanes, value, step);
        value = other > value ? other : value;
    }
    return value;
}

__device__ inline bool any(bool value)
{
    return __any_sync(all_lanes, value) != 0;
}

__device__ inline size_t thread_number()
{
    return (size_t)blockIdx.x * blockDim.x + threadIdx.x;
}

/* Doubles as integers of the same order, for atomic minima and maxima. */
__device__ inline unsigned long long ordered(double value)
{
    unsigned long long bits = (unsigned long long)__double_as_longlong(value);
    return bits >> 63 != 0 ? ~bits : bits | 1ull << 63;
}

__host__ __device__ inline double unordered(unsigned long long bits)
{
    double value;
    bits = bits >> 63 != 0 ? bits & ~(1ull << 63) : ~bits;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* ------------------------------------------------------------------------------------------------------
   >>curve        Points in the order of the Hilbert curve, duplicates set aside.
   In: packed points and weights.  Out: records by rank, the caller's id of each rank, and for each point the one that
   it duplicates, all as >>order of pbw.h has them: the same keys; short runs of equal keys in lexicographic order;
   the points of a long run get keys from a grid over their own box, and so on.  The long runs of one depth are taken
   together: their points are gathered, sorted by the new key, then by their run, and put back.
   ------------------------------------------------------------------------------------------------------ */
struct input {
    const void *points, *weights;
    size_t count;
    int dim, is_float;
};

struct survey {                                      /* what one pass over the points finds */
    unsigned long long low[4], high[4];              /* of x, y, z and the weight, ordered */
    int unit;                                        /* exponent of the common grid, see pbw__grid */
    uint32_t bad, long_runs, duplicates;
};

__device__ inline void fetch(const input &in, size_t i, double *c)
{
    auto number = [&](const void *of, size_t at) {
        return (in.is_float ? (double)((const float *)of)[at] : ((const double *)of)[at]) + 0.0;
    };
    for (int k = 0; k < in.dim; k++) {
        c[k] = number(in.points, i * (size_t)in.dim + (size_t)k);
    }
    c[in.dim] = in.weights != NULL ? number(in.weights, i) : 0.0;
}

/* Points and their keys, all or those of long runs. */
struct keyed {
    input in;
    int index_bits, bits;                            /* of the index, which is below the key; of a coordinate */
    uint16_t step[12 << 3];                          /* the automaton of pbw.h */
    uint64_t *key;
    __device__ size_t index(size_t i) const { return (size_t)(key[i] & (((uint64_t)1 << index_bits) - 1)); }
    __device__ bool tie(size_t i, size_t j) const { return key[i] >> index_bits == key[j] >> index_bits; }
    __device__ void read(size_t i, double *c) const { fetch(in, index(i), c); }
    __device__ uint64_t key_of(size_t point, const pbw__box &box) const
    {
        double c[4];
        fetch(in, point, c);
        return (in.dim == 3 ? pbw__hilbert_key(step, &box, c, 3, 1)
                            : pbw__hilbert_key(step, &box, c, 2, 1)) << index_bits | point;
    }
    /* In a short run; of points at one place, the one that stays comes first. */
    __device__ bool before(size_t i, size_t j) const
    {
        double x[4], y[4];
        read(i, x);
        read(j, y);
        return pbw__comes_before(x, index(i), y, index(j), in.dim);
    }
};

__device__ inline int lowest_bit(double value)       /* its exponent; 1024 of zero */
{
    int64_t mantissa;
    int exponent = pbw__decode(value, &mantissa);
    return mantissa == 0 ? 1024 : exponent + __ffsll((long long)mantissa) - 1;
}

__global__ void survey_kernel(input in, survey *out)
{
    unsigned long long low[4], high[4];
    int unit = 1024, dim = in.dim;
    bool bad = false;
    for (int k = 0; k < 4; k++) {
        low[k] = ~0ull;
        high[k] = 0;
    }
    for (size_t i = thread_number(); i < in.count; i += (size_t)gridDim.x * blockDim.x) {
        double c[4];
        fetch(in, i, c);
        for (int k = 0; k <= dim; k++) {
            unsigned long long value = ordered(c[k]);
            int exponent = lowest_bit(c[k]);
            bad = bad || !(c[k] - c[k] == 0.0);
            low[k] = min(low[k], value);
            high[k] = max(high[k], value);
            unit = min(unit, k == dim && exponent != 1024 ? (exponent - (exponent & 1)) / 2 : exponent);
        }
    }
    bad = any(bad);
    for (int k = 0; k <= dim; k++) {
        low[k] = tile_min<32>(low[k]);
        high[k] = tile_max<32>(high[k]);
    }
    unit = tile_min<32>(unit);
    if ((threadIdx.x & 31) == 0) {
        for (int k = 0; k <= dim; k++) {
            atomicMin(&out->low[k], low[k]);
            atomicMax(&out->high[k], high[k]);
        }
        atomicMin(&out->unit, unit);
        if (bad) {
            atomicOr(&out->bad, 1u);
        }
    }
}

__global__ void key_kernel(const __grid_constant__ keyed k, const __grid_constant__ pbw__box domain)
{
    size_t i = thread_number();
    if (i < k.in.count) {
        k.key[i] = k.key_of(i, domain);
    }
}

/* Long runs: where they begin and end among all keys, and among the gathered ones. */
struct run_list {
    uint32_t *head, *end, *length, *offset;
};

/* Finds runs among count keys, which are all keys or, with segment, those gathered from the runs of a list.  The
   first of a short run puts it into order: lexicographic, then the larger weight, then the lower index.  Long ones go
   to found, with the end of all that they could reach. */
__global__ void run_kernel(const __grid_constant__ keyed k, size_t count, const uint32_t *segment, run_list of,
                           run_list found, survey *out)
{
    size_t i = thread_number(), end = i + 1, begin = 0, limit = count, shift = 0;
    if (i >= count) {
        return;
    }
    if (segment != NULL) {
        uint32_t r = segment[i];
        begin = of.offset[r];
        limit = begin + of.length[r];
        shift = of.head[r] - begin;
    }
    if (i > begin && k.tie(i - 1, i)) {
        return;
    }
    while (end < limit && end - i <= PBW__SHORT_RUN && k.tie(end, i)) {
        end++;
    }
    if (end - i > PBW__SHORT_RUN) {
        uint32_t at = atomicAdd(&out->long_runs, 1u);
        found.head[at] = (uint32_t)(i + shift);
        found.end[at] = (uint32_t)(limit + shift);
        return;
    }
    for (size_t j = i + 1; j < end; j++) {
        for (size_t hole = j; hole > i && k.before(hole, hole - 1); hole--) {
            exchange(k.key[hole], k.key[hole - 1]);
        }
    }
}

/* A warp a run: its length and box; length 0 if all its points lie at one place.  Then the best of them goes first,
   which root says. */
__global__ void measure_kernel(const __grid_constant__ keyed k, run_list runs, uint32_t count, pbw__box *box,
                               uint32_t *root)
{
    uint32_t r = blockIdx.x * (blockDim.x / 32) + threadIdx.x / 32, lane = threadIdx.x & 31;
    unsigned long long lowest[3] = { ~0ull, ~0ull, ~0ull }, highest[3] = { 0, 0, 0 };
    if (r >= count) {
        return;
    }
    uint32_t head = runs.head[r], end = head, limit = runs.end[r], best = head;
    for (unsigned vote = all_lanes; vote == all_lanes; end += (uint32_t)__popc(vote)) {
        uint32_t i = end + lane;
        bool inside = i < limit && k.tie(i, head);
        vote = __ballot_sync(all_lanes, inside);
        if (inside) {
            double c[4];
            k.read(i, c);
            for (int j = 0; j < k.in.dim; j++) {
                unsigned long long value = ordered(c[j]);
                lowest[j] = min(lowest[j], value);
                highest[j] = max(highest[j], value);
            }
            best = k.before(i, best) ? i : best;
        }
    }
    for (int step = 16; step > 0; step /= 2) {
        uint32_t other = __shfl_xor_sync(all_lanes, best, step);
        best = k.before(other, best) ? other : best;
    }
    double side = 0.0;
    for (int j = 0; j < k.in.dim; j++) {
        double l = unordered(tile_min<32>(lowest[j]));
        side = fmax(side, unordered(tile_max<32>(highest[j])) - l);
        if (lane == 0) {
            box[r].low[j] = l;
        }
    }
    __syncwarp();
    if (lane == 0) {
        box[r].scale = 1.0;
        box[r].extent = side;
        box[r].bits = k.bits;
        runs.length[r] = side > 0.0 ? end - head : 0;
        if (side == 0.0) {
            exchange(k.key[head], k.key[best]);
        }
    }
    for (uint32_t i = head + lane; side == 0.0 && i < end; i += 32) {
        root[i] = head;
    }
}

/* A warp a run: its points with their new keys. */
__global__ void rekey_kernel(const __grid_constant__ keyed k, run_list runs, uint32_t count, const pbw__box *box,
                             uint64_t *gathered, uint32_t *segment)
{
    uint32_t r = blockIdx.x * (blockDim.x / 32) + threadIdx.x / 32;
    for (uint32_t i = threadIdx.x & 31; r < count && i < runs.length[r]; i += 32) {
        gathered[runs.offset[r] + i] = k.key_of(k.index(runs.head[r] + i), box[r]);
        segment[runs.offset[r] + i] = r;
    }
}

__global__ void put_back_kernel(const uint64_t *gathered, const uint32_t *segment, size_t count, run_list runs,
                                uint64_t *key)
{
    size_t i = thread_number();
    if (i < count) {
        uint32_t r = segment[i];
        key[runs.head[r] + (i - runs.offset[r])] = gathered[i];
    }
}

/* first[i] = 1 if the i-th point on the curve lies at a place of its own; the best of a place comes first.  root:
   NULL, or where a long run at one place begins. */
__global__ void place_kernel(const __grid_constant__ keyed k, const uint32_t *root_of, uint32_t *first,
                             uint32_t *canonical, survey *out)
{
    size_t i = thread_number();
    bool repeats = false;
    if (i < k.in.count) {
        double x[4], y[4];
        const bool rooted = root_of != NULL && root_of[i] != none;
        size_t root = rooted ? root_of[i] : i;
        k.read(i, x);
        for (; !rooted && root > 0 && k.tie(root - 1, i); root--) {
            k.read(root - 1, y);
            if (!pbw__same_place(x, y, k.in.dim)) {
                break;
            }
        }
        repeats = root != i;
        first[i] = !repeats;
        canonical[k.index(i)] = (uint32_t)k.index(root);
    }
    unsigned vote = __ballot_sync(all_lanes, repeats);
    if ((threadIdx.x & 31) == 0 && vote != 0) {
        atomicAdd(&out->duplicates, (uint32_t)__popc(vote));
    }
}

/* rank: of each point on the curve the number of firsts before it, or NULL if there are no duplicates. */
__global__ void gather_kernel(const __grid_constant__ keyed k, const uint32_t *first, const uint32_t *rank,
                              record *point, uint32_t *id)
{
    size_t i = thread_number();
    if (i < k.in.count && (rank == NULL || first[i] != 0)) {
        const size_t at = rank == NULL ? i : rank[i];
        record r;
        r.c[3] = 0.0;
        k.read(i, r.c);
        point[at] = r;
        id[at] = (uint32_t)k.index(i);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>tree         Groups of 8 points, boxes of 32 boxes; for each group the list of groups near it.
   In: a space.  Out: a tree, of which a node's children are neighbours in memory, so that a warp looks at all of them
   at once; and lists.
   ------------------------------------------------------------------------------------------------------ */
const int group_size = 8, list_size = 192;

struct near_list {
    uint32_t length;                                 /* 0: none, the stars of the group go to the second rung */
    float reach, start;                              /* it covers the group's box grown by reach; start: a radius of
                                                        about 33 points, which the first close entries cover */
    uint32_t close;
};

__device__ inline double in_units(const space &s, const record &r, int k)
{
    return (r.c[k] - s.low[k]) * s.unit;
}

__global__ void group_kernel(const __grid_constant__ space s, int dim, box *out, float4 *rough, uint32_t size)
{
    size_t g = thread_number();
    if (g < size) {
        box b = { { 4.0f, 4.0f, 4.0f }, { -4.0f, -4.0f, -4.0f }, -HUGE_VALF, 0.0f };
        uint32_t first = (uint32_t)g * group_size, end = first + group_size < s.count ? first + group_size : s.count;
        for (uint32_t i = first; i < end; i++) {
            record r = s.point[i];
            float t3 = dim == 3 ? (float)in_units(s, r, 2) : 0.0f;
            rough[i] = make_float4((float)in_units(s, r, 0), (float)in_units(s, r, 1), t3, 0.0f);
            for (int k = 0; k < dim; k++) {
                double t = in_units(s, r, k);
                b.low[k] = fminf(b.low[k], __double2float_rd(t));
                b.high[k] = fmaxf(b.high[k], __double2float_ru(t));
            }
            b.weight = fmaxf(b.weight, __double2float_ru((r.c[dim] - s.heaviest) * (s.unit * s.unit)));
        }
        if (dim == 2) {
            b.low[2] = b.high[2] = 0.0f;
        }
        out[g] = b;
    }
}

__global__ void box_kernel(const box *child, uint32_t children, box *out, uint32_t size)
{
    size_t g = thread_number();
    if (g < size) {
        box b = child[g * 32];
        uint32_t end = (uint32_t)g * 32 + 32 < children ? (uint32_t)g * 32 + 32 : children;
        for (uint32_t i = (uint32_t)g * 32 + 1; i < end; i++) {
            add_box(b, child[i]);
        }
        out[g] = b;
    }
}

const int stack_size = 32 * tree_levels;             /* each level leaves at most 31 siblings of the node in hand */

/* The side of a cube (square) that holds 64 points near a group, by the box of 8 groups. */
__device__ inline float side_near(const tree &t, int dim, uint32_t g)
{
    const uint32_t first = g & ~7u;
    box around = t.level[0][g];
    for (uint32_t i = first; i < first + 8 && i < t.size[0]; i++) {
        add_box(around, t.level[0][i]);
    }
    float x = around.high[0] - around.low[0], y = around.high[1] - around.low[1], z = around.high[2] - around.low[2];
    float longest = fmaxf(x, fmaxf(y, z));
    return fmaxf(dim == 3 ? cbrtf(x * y * z) : sqrtf(x * y), 0.08f * longest);
}

/* Lists the groups within reach of a box; returns their number, or one above list_size if they are more. */
__device__ inline int list_within(const tree &t, const box &own, float reach, uint32_t *found, uint32_t *stack)
{
    int lane = (int)threadIdx.x & 31, depth = 0, length = 0, level = t.levels - 1;
    uint32_t from = 0;
    float lo[3], hi[3];
    for (int k = 0; k < 3; k++) {
        lo[k] = own.low[k] - reach;
        hi[k] = own.high[k] + reach;
    }
    for (;;) {
        uint32_t node = from + (uint32_t)lane;
        bool touches = false;
        if (node < t.size[level]) {
            box b = t.level[level][node];
            touches = b.low[0] <= hi[0] && b.high[0] >= lo[0] && b.low[1] <= hi[1] && b.high[1] >= lo[1]
                   && b.low[2] <= hi[2] && b.high[2] >= lo[2];
        }
        unsigned vote = __ballot_sync(all_lanes, touches);
        int at = __popc(vote & lanes_below<32>());
        if (level == 0) {
            if (touches && length + at < list_size) {
                found[length + at] = node;
            }
            length += __popc(vote);
        } else {
            if (touches) {
                stack[depth + at] = (uint32_t)level << 29 | node;
            }
            depth += __popc(vote);
        }
        __syncwarp();
        if (depth == 0 || length > list_size) {
            return length;
        }
        uint32_t top = stack[--depth];
        __syncwarp();
        level = (int)(top >> 29) - 1;
        from = (top & 0x1fffffffu) * 32;
    }
}

/* Writes the groups found for group g, the nearest centre first, by counting; returns, in all lanes, after how many
   of them none is closer than start. */
__device__ inline uint32_t sort_list(const tree &t, uint32_t g, float start, uint32_t *found, int length,
                                     uint32_t *list)
{
    const box own = t.level[0][g];
    int lane = (int)threadIdx.x & 31;
    uint32_t key[list_size / 32], value[list_size / 32], before[list_size / 32] = { 0 }, close = 0;
    bool is_close[list_size / 32];
    for (int i = 0; i < list_size / 32; i++) {
        key[i] = none;
        is_close[i] = false;
        if (i * 32 + lane < length) {
            box b = t.level[0][value[i] = found[i * 32 + lane]];
            float d = 0.0f, gaps = 0.0f;
            for (int k = 0; k < 3; k++) {
                float c = b.low[k] + b.high[k] - (own.low[k] + own.high[k]);
                float gap = fmaxf(fmaxf(b.low[k] - own.high[k], own.low[k] - b.high[k]) - 9.6e-7f, 0.0f);
                d = fmaf(c, c, d);
                gaps = fmaf(gap, gap, gaps);
            }
            is_close[i] = gaps * 0.9999f < start * start;
            key[i] = value[i] == g ? 0 : (__float_as_uint(d) & ~255u) + (uint32_t)(i * 32 + lane) + 1;
        }
    }
    __syncwarp();
    for (int i = 0; i < list_size / 32; i++) {
        if (i * 32 + lane < length) {
            found[i * 32 + lane] = key[i];
        }
    }
    __syncwarp();
    for (int j = 0; j < length; j++) {
        uint32_t other = found[j];
        for (int i = 0; i < list_size / 32; i++) {
            before[i] += other < key[i];
        }
    }
    for (int i = 0; i < list_size / 32; i++) {
        if (i * 32 + lane < length) {
            list[before[i]] = value[i];
            close = is_close[i] && before[i] >= close ? before[i] + 1 : close;
        }
    }
    return none - tile_min<32>(none - close);
}

/* A warp a group, of those from first to end.  The reach starts as a part of the side near the group, and changes
   until the list fits. */
__global__ void list_kernel(const __grid_constant__ tree t, int dim, uint32_t first_group, uint32_t end_group,
                            uint32_t *list, near_list *info)
{
    __shared__ uint32_t shared[4][list_size + stack_size];
    uint32_t row = blockIdx.x * (blockDim.x / 32) + threadIdx.x / 32, g = first_group + row;
    uint32_t *found = shared[threadIdx.x / 32];
    if (g >= end_group) {
        return;
    }
    const box own = t.level[0][g];
    const float side = side_near(t, dim, g), start = (dim == 3 ? 0.5f : 0.32f) * side;
    float reach = (dim == 3 ? 0.65f : 0.40f) * side;
    int length = 0;
    for (int round = 0; round < 12; round++) {
        length = list_within(t, own, reach, found, found + list_size);
        if (length > list_size) {
            reach *= 0.75f;
        } else if (length < 24 && round < 3 && (uint32_t)length < t.size[0]) {
            reach *= 1.4f;
        } else {
            break;
        }
    }
    length = length > list_size ? 0 : length;
    const uint32_t close = sort_list(t, g, start, found, length, list + (size_t)row * list_size);
    if ((threadIdx.x & 31) == 0) {
        near_list n = { (uint32_t)length, reach, start, close };
        info[row] = n;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>sphere       The float form of a conflict test and its bound; the exact test.
   Everything is relative to the star's vertex v and in units of the space: a = (a' - v') unit.  For a simplex
   (v, a, b, c) with D = a . (b x c) > 0 and lifts l = |a|^2 - (w_a - w_v) the point p is in conflict if and only if

       l_p - q . p < 0,     q = N / D,     N = l_a (b x c) + l_b (c x a) + l_c (a x b):

   q is twice the centre of the (ortho)sphere.  For an infinite simplex on the facet (v, a, b) it is -q . p < 0 with
   q = 2^112 (a x b) / |a x b|: beside it the lift, below 2^41, does not count.  In the plane D = a x b,
   N = l_a b' - l_b a' with a' = a turned by a right angle.
   A sphere is four floats: q, and Q, a size that carries the error of q; Q >= 2^112 marks an infinite simplex.  It is
   calculated in doubles, or in floats: differences are those of doubles, rounded, and nothing else is double, which
   many cards are slow at.  Let f = 2^-24, and g = 2^-53 for doubles, f for floats, A = |a|, L_a = |a|^2 + |w_a - w_v|
   and so on.

     D    3 factors for differences, 5 for products and sums, terms at most 1.16 ABC (the permanent of a matrix with
          rows of norm 1 is at most 6/3^1.5):                                     error at most  10 g ABC
     N    lifts 6 factors, crosses 4, product and sums 3, terms at most sqrt 2 E,
          E = L_a BC + L_b AC + L_c AB:                                      error at most  19 g E
     q    doubles: if D > 2^-48 ABC > 20 g ABC the true D is at least half of it:     at most  40 g (E + |q| ABC) / D
          floats: if D > 2^-16 ABC the true D is at least 0.96 of it:                 at most  20 g (E + |q| ABC) / D
          and |q| 4 f more for the inverse, the product and rounding to float.
     test lift 6, p, q rounded to floats or so calculated; 4 sums:           error at most  10 f L_p + 9 f |q| P more
          (a float p is off by f P, that is f |q| P in q . p; each fused step rounds a sum of at most L_p + |q| P).

   With Q = |q| + h (E + |q| ABC) / D, h = 2^-27 for doubles and 21/16 > 20/16 for floats, the bound 2^-20 (L_p + Q P)
   = 16 f (L_p + |q| P) + 16 f h P (...) holds all that, roots that are off by 2^-22, and for an infinite simplex the
   lift: 8 f Q P > 2^41.  So the true q is within 2^-20 Q, the true centre within 2^-21 Q of q / 2, and the radius is
   at most |q| / 2 + 2^-21 Q.  Q is infinite if nothing is known; then, and for P below 2^-50 (floats: 2^-24), where
   squares (products of four lengths) might underflow, the test says open.  In the plane and for infinite simplices
   there are fewer factors: a x b is off by 6 g AB, which is little beside it if its length is more than 2^-48 (2^-12)
   AB, and then its direction by 12 g AB / |a x b| <= 16 f h AB / |a x b|.

   A wall is an infinite simplex on a side of the box of all points: v, a and b have the same extreme coordinate.  No
   point is beyond it, and one in its plane is in conflict with it exactly if it is with the finite simplex behind it,
   which is in the star too.  So walls are left out of the search (else each point of a flat side would be a candidate
   for each star there).  A wall has Q = -2^111: its q is exact, and no point seems to be in conflict with it.
   ------------------------------------------------------------------------------------------------------ */
const float slack = 9.5367431640625e-7f;             /* 2^-20 */
const float far_away = 5.192296858534828e33f;        /* 2^112 */
const int open_sign = PBW__OPEN;

template <typename REAL> struct place {              /* relative to v, in units */
    REAL x[3], w;
};

/* What differs: a difference in units; the squares that are large enough, D / ABC and (|a x b| / AB)^2 where the
   bounds begin to hold, and the factor of the error in Q. */
template <typename REAL> struct sizes;
template <> struct sizes<double> {
    static __device__ double scaled(double difference, double unit) { return difference * unit; }
    static __device__ double least() { return 7.9e-31; }                        /* 2^-100 */
    static __device__ double flat() { return 3.5527136788005009e-15; }          /* 2^-48 */
    static __device__ double thin() { return 1.3e-29; }                         /* 2^-96 */
    static __device__ double error() { return 7.4505805969238281e-9; }          /* 2^-27 */
    static __device__ double inverse(double d) { return 1.0 / d; }
};
template <> struct sizes<float> {
    static __device__ float scaled(double difference, double unit)
    {                                                /* never 0 if the difference is not: walls depend on it */
        float x = (float)(difference * unit);
        return x == 0.0f && difference != 0.0 ? 1e-37f : x;
    }
    static __device__ float least() { return 3.6e-15f; }                        /* 2^-48 */
    static __device__ float flat() { return 1.52587890625e-5f; }                /* 2^-16 */
    static __device__ float thin() { return 6e-8f; }                            /* 2^-24 */
    static __device__ float error() { return 1.3125f; }
    static __device__ float inverse(float d) { return __fdividef(1.0f, d); }    /* relative error 2^-22 */
};

struct probe {                                       /* a place in floats, with the sizes of its errors */
    float x[3], lift, load, size;                    /* load: 2^-20 L_p; size: 2^-20 P, or infinity */
};

__device__ inline float dot(const float *a, const float *b)
{
    return fmaf(a[0], b[0], fmaf(a[1], b[1], a[2] * b[2]));
}

__device__ inline float root(float value)            /* relative error 2^-22 */
{
    float result;
    asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(value));
    return result;
}

template <int DIM, typename REAL>
__device__ inline place<REAL> relative(const space &s, const record &v, const record &p)
{
    place<REAL> r;
    for (int k = 0; k < 3; k++) {
        r.x[k] = k < DIM ? sizes<REAL>::scaled(p.c[k] - v.c[k], s.unit) : 0;
    }
    r.w = (REAL)((p.c[DIM] - v.c[DIM]) * (s.unit * s.unit));
    return r;
}

template <int DIM, typename REAL> __device__ inline REAL square(const REAL *x)
{
    return DIM == 3 ? x[0] * x[0] + x[1] * x[1] + x[2] * x[2] : x[0] * x[0] + x[1] * x[1];
}

template <int DIM, bool WEIGHTED, typename REAL> __device__ inline probe probe_of(const place<REAL> &p)
{
    probe r;
    REAL l = square<DIM>(p.x);
    for (int k = 0; k < 3; k++) {
        r.x[k] = (float)p.x[k];
    }
    r.load = (float)l;
    r.lift = WEIGHTED ? (float)(l - p.w) : r.load;
    r.size = r.load > sizes<REAL>::least() ? slack * root(r.load) : HUGE_VALF;
    r.load = slack * (WEIGHTED ? r.load + fabsf((float)p.w) : r.load);
    return r;
}

__device__ inline bool is_wall(float4 q)
{
    return q.w < 0.0f;
}

/* The walls through v, as bits: the lower and the upper side of each axis. */
template <int DIM> __device__ inline unsigned walls_of(const space &s, const record &v)
{
    unsigned walls = 0;
    for (int k = 0; k < DIM; k++) {
        walls |= (v.c[k] == s.low[k] ? 1u : 0u) << (2 * k) | (v.c[k] == s.end[k] ? 2u : 0u) << (2 * k);
    }
    return walls;
}

/* 1: in conflict, 0: not, open_sign. */
__device__ inline int side(float4 q, const probe &p)
{
    float s = fmaf(-q.x, p.x[0], fmaf(-q.y, p.x[1], fmaf(-q.z, p.x[2], p.lift)));
    float e = fmaf(fabsf(q.w), p.size, p.load);
    return s > e ? 0 : s < -e ? 1 : open_sign;
}

__device__ inline float4 unknown_sphere()
{
    return make_float4(0.0f, 0.0f, 0.0f, HUGE_VALF);
}

template <typename REAL>
__device__ inline float4 sphere_of(const REAL *n, REAL d, REAL e, REAL product)
{
    if (!(d > sizes<REAL>::flat() * product)) {
        return unknown_sphere();
    }
    REAL inverse = sizes<REAL>::inverse(d), x = n[0] * inverse, y = n[1] * inverse, z = n[2] * inverse;
    REAL square_q = x * x + y * y + z * z, size = root((float)square_q);
    if (!(square_q < (REAL)1e36)) {
        return unknown_sphere();
    }
    return make_float4((float)x, (float)y, (float)z,
                       (float)(size + sizes<REAL>::error() * (e + size * product) * inverse));
}

template <int DIM, bool WEIGHTED, typename REAL>
__device__ inline float4 sphere(const place<REAL> &pa, const place<REAL> &pb, const place<REAL> &pc)
{
    const REAL *a = pa.x, *b = pb.x, *c = pc.x, least = sizes<REAL>::least();
    REAL la = square<DIM>(a), lb = square<DIM>(b), lc = DIM == 3 ? square<DIM>(c) : (REAL)1;
    REAL n[3] = { 0, 0, 0 };
    if (!(la > least && lb > least && lc > least)) {
        return unknown_sphere();
    }
    REAL A = root((float)la), B = root((float)lb), C = DIM == 3 ? root((float)lc) : 1.0f;
    REAL La = la, Lb = lb, Lc = lc;
    if (WEIGHTED) {
        La += fabs(pa.w), Lb += fabs(pb.w), Lc += fabs(pc.w);
        la -= pa.w, lb -= pb.w, lc -= pc.w;
    }
    if (DIM == 2) {
        n[0] = la * b[1] - lb * a[1];
        n[1] = lb * a[0] - la * b[0];
        return sphere_of(n, a[0] * b[1] - a[1] * b[0], La * B + Lb * A, A * B);
    }
    REAL bc[3] = { b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0] };
    REAL ca[3] = { c[1] * a[2] - c[2] * a[1], c[2] * a[0] - c[0] * a[2], c[0] * a[1] - c[1] * a[0] };
    REAL ab[3] = { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
    for (int k = 0; k < 3; k++) {
        n[k] = la * bc[k] + lb * ca[k] + lc * ab[k];
    }
    return sphere_of(n, a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2], La * B * C + Lb * A * C + Lc * A * B, A * B * C);
}

/* The half-space beyond the facet (v, a, b); in the plane to the left of the line from v to a, or for sign -1 to its
   right. */
template <int DIM, typename REAL>
__device__ inline float4 half_space(const place<REAL> &pa, const place<REAL> &pb, REAL sign, unsigned walls)
{
    const REAL *a = pa.x, *b = pb.x, least = sizes<REAL>::least();
    REAL la = square<DIM>(a), lb = DIM == 3 ? square<DIM>(b) : (REAL)1, n[3] = { -a[1] * sign, a[0] * sign, 0 };
    if (DIM == 3) {
        n[0] = a[1] * b[2] - a[2] * b[1];
        n[1] = a[2] * b[0] - a[0] * b[2];
        n[2] = a[0] * b[1] - a[1] * b[0];
    }
    for (int k = 0; k < DIM; k++) {
        if (a[k] == 0 && (DIM == 2 || b[k] == 0) && (walls >> (n[k] > 0 ? 2 * k + 1 : 2 * k) & 1) != 0) {
            float one = n[k] > 0 ? far_away : -far_away;
            return make_float4(k == 0 ? one : 0.0f, k == 1 ? one : 0.0f, k == 2 ? one : 0.0f, -0.5f * far_away);
        }
    }
    REAL square_n = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (!(la > least && lb > least && square_n > sizes<REAL>::thin() * la * lb)) {
        return unknown_sphere();
    }
    REAL inverse = sizes<REAL>::inverse(sqrt(square_n));
    return make_float4((float)(n[0] * inverse) * far_away, (float)(n[1] * inverse) * far_away,
                       (float)(n[2] * inverse) * far_away,
                       (float)(1 + sizes<REAL>::error() * sqrt(la * lb) * inverse) * far_away);
}

/* A triangle: three local numbers of vertices, 0 being the vertex at infinity, and a mark that no point of the input
   is in conflict with the simplex: then it is final, no insertion removes it. */
const uint32_t corner_mask = 1023, verified = 1u << 30;

__device__ inline uint32_t corner(uint32_t triangle, int k)
{
    return triangle >> (10 * k) & corner_mask;
}

/* The number of the triangle that has the directed edge (a, b); in the plane of the edge that begins with a, or for
   a == none ends with b. */
template <int DIM> __device__ int triangle_with(const uint32_t *triangle, int count, uint32_t a, uint32_t b)
{
    for (int t = 0; t < count; t++) {
        for (int k = 0; k < DIM; k++) {
            uint32_t from = corner(triangle[t], k), to = corner(triangle[t], k + 1 == DIM ? 0 : k + 1);
            if (DIM == 3 ? from == a && to == b : k == 0 && (a == none ? to == b : from == a)) {
                return t;
            }
        }
    }
    return -1;
}

/* The number of the triangle across from corner k of another. */
template <int DIM> __device__ inline int mate_of(const uint32_t *triangle, int count, uint32_t packed, int k)
{
    return DIM == 3 ? triangle_with<DIM>(triangle, count, corner(packed, (k + 2) % 3), corner(packed, (k + 1) % 3))
         : k == 0 ? triangle_with<DIM>(triangle, count, corner(packed, 1), 0)
                  : triangle_with<DIM>(triangle, count, none, corner(packed, 0));
}

/* The exact answer where floats leave it open: is point p in conflict with triangle t of the star of v?
   For an infinite simplex with p in the plane of its facet it is that of the finite simplex behind the facet. */
template <int DIM, bool WEIGHTED>
__device__ __noinline__ int settle(const space &s, uint32_t v, const uint32_t *id, const uint32_t *triangle,
                                   int count, int t, uint32_t p, pbw__digit *pool)
{
    const double *row[4], *origin = s.point[p].c;
    uint32_t c[3];
    int at = -1;
    for (int k = 0; k < DIM; k++) {
        c[k] = corner(triangle[t], k);
        at = c[k] == 0 ? k : at;
    }
    row[0] = s.point[v].c;
    if (at >= 0) {
        if (DIM == 3) {
            row[1] = s.point[id[c[(at + 1) % 3]]].c;
            row[2] = s.point[id[c[(at + 2) % 3]]].c;
            row[3] = origin;
        } else {
            row[1] = at == 1 ? s.point[id[c[0]]].c : origin;
            row[2] = at == 1 ? origin : s.point[id[c[1]]].c;
        }
        const int sign = pbw__orient_in(pool, DIM, row, &s.grid);
        at = mate_of<DIM>(triangle, count, triangle[t], at);
        if (sign != 0 || at < 0) {
            return sign == PBW__OPEN || at < 0 ? open_sign : sign > 0;
        }
        t = at;
    }
    for (int k = 0; k < DIM; k++) {
        uint32_t a = corner(triangle[t], k);
        if (a == 0) {
            return open_sign;
        }
        row[k + 1] = s.point[id[a]].c;
    }
    return pbw__conflict_in(pool, DIM, row, origin, &s.grid);
}

/* ------------------------------------------------------------------------------------------------------
   >>star         One star: a link of triangles (in the plane: edges), each counter-clockwise as seen from outside.
   Holds between insertions: the link is closed; every simplex (v, triangle) is positively oriented, or infinite with
   corner 0; spheres are those of the simplices; the bit matrix is all zeros.
   ------------------------------------------------------------------------------------------------------ */
template <bool WIDE> struct star_types {
    typedef std::conditional_t<WIDE, uint16_t, uint8_t> number;
    typedef std::conditional_t<WIDE, uint32_t, uint16_t> pair;
    typedef std::conditional_t<WIDE, uint64_t, uint32_t> rounds;
    static const int bits = WIDE ? 10 : 8;
};

/* What a rung calculates in. */
template <bool EXACT> using rung_real = std::conditional_t<EXACT, double, float>;

/* NT triangles, NV vertices, SCRATCH words for the rung's search. */
template <int DIM, bool WEIGHTED, int NT, int NV, int SCRATCH, typename REAL> struct star {
    typedef star_types<(NT > 256)> types;
    typedef REAL real;
    static const int dim = DIM, triangles = NT, vertices = NV, words = NV / 32;
    static const bool weighted = WEIGHTED;
    float4 sphere[NT];
    REAL x[NV][DIM], w[WEIGHTED ? NV : 1];
    uint32_t id[NV], triangle[NT], matrix[NV * words], used[words], scratch[SCRATCH];
    typename types::pair border[NT + 4];
    typename types::number cavity[NT];
};

/* The place of a point of a star S, and of a candidate or, where there is none, v. */
template <typename S> using place_in = place<typename S::real>;

template <typename S>
__device__ inline place_in<S> candidate_place(const space &all, const record &own, uint32_t v, uint32_t candidate)
{
    return relative<S::dim, typename S::real>(all, own, all.point[candidate != none ? candidate : v]);
}

/* Larger stars have kernels of their own in >>cells. */
const int small_triangles = 60, small_vertices = 32;

enum { star_changed = 1, star_open = 2, star_full = 4, star_hidden = 8 };

__device__ inline uint32_t pack(uint32_t a, uint32_t b, uint32_t c)
{
    return a | b << 10 | c << 20;
}

template <typename S> __device__ inline void set_vertex(S &s, uint32_t number, uint32_t id, const place_in<S> &p)
{
    s.id[number] = id;
    for (int k = 0; k < S::dim; k++) {
        s.x[number][k] = p.x[k];
    }
    if (S::weighted) {
        s.w[number] = p.w;
    }
}

template <typename S> __device__ inline place_in<S> vertex_place(const S &s, uint32_t number)
{
    place_in<S> p;
    for (int k = 0; k < 3; k++) {
        p.x[k] = k < S::dim ? s.x[number][k] : 0;
    }
    p.w = S::weighted ? s.w[number] : 0;
    return p;
}

/* The vertex at infinity has a place too: loads that are not used find it there. */
template <typename S> __device__ inline void set_infinity(S &s)
{
    const place_in<S> origin = { { 0, 0, 0 }, 0 };
    set_vertex(s, 0, none, origin);
}

/* The sphere of triangle (a, b, c); in the plane of edge (a, b).  0 is the vertex at infinity. */
template <int DIM, bool WEIGHTED, typename REAL>
__device__ inline float4 sphere_of_triangle(uint32_t a, uint32_t b, uint32_t c, const place<REAL> &pa,
                                            const place<REAL> &pb, const place<REAL> &pc, unsigned walls)
{
    if (DIM == 3) {
        if (a != 0 && b != 0 && c != 0) {
            return sphere<DIM, WEIGHTED>(pa, pb, pc);
        }
        place<REAL> from, to;                        /* the finite edge, selected without pointers to registers */
        for (int k = 0; k < 3; k++) {
            from.x[k] = a == 0 ? pb.x[k] : b == 0 ? pc.x[k] : pa.x[k];
            to.x[k] = a == 0 ? pc.x[k] : b == 0 ? pa.x[k] : pb.x[k];
        }
        return half_space<DIM>(from, to, (REAL)1, walls);
    }
    if (a != 0 && b != 0) {
        return sphere<DIM, WEIGHTED>(pa, pb, pc);
    }
    place<REAL> end;
    for (int k = 0; k < 3; k++) {
        end.x[k] = a == 0 ? pb.x[k] : pa.x[k];
    }
    return half_space<DIM>(end, end, (REAL)(a == 0 ? -1 : 1), walls);
}

/* used: the vertices that triangles have, and 0. */
template <int T, typename S> __device__ inline void find_used(S &s, bool go, int count)
{
    int lane = (int)threadIdx.x & (T - 1);
    __syncwarp();
    if (go) {
        for (int i = lane; i < s.words; i += T) {
            s.used[i] = i == 0;
        }
    }
    __syncwarp();
    if (go) {
        for (int t = lane; t < count; t += T) {
            for (int k = 0; k < S::dim; k++) {
                uint32_t c = corner(s.triangle[t], k);
                atomicOr(&s.used[c >> 5], 1u << (c & 31));
            }
        }
    }
    __syncwarp();
}

/* The cavity of a point in a star: conflicts triangles; its border: edges; and the number of the point. */
struct hole {
    int conflicts, edges;
    uint32_t number;
};

/* As settle, for p relative to v, by doubles that round nothing: on a small grid all products are integers in its
   unit, below 2^53 (>>cavity3 of pbw.h: there p is the origin, here v, but the 24 products have the same bound).  The
   coefficients of the lifts are those of pbw__tie.  open_sign if a height is too large for that. */
template <typename S>
__device__ __noinline__ int settle_on_grid(const S &s, int count, int t, double limit, double px, double py,
                                           double pz, double pw)
{
    const double p[3] = { px, py, pz }, lift = square<S::dim>(p) - (S::weighted ? pw : 0.0);
    if (!(square<S::dim>(p) + (S::weighted ? fabs(pw) : 0.0) < limit)) {
        return open_sign;
    }
    for (int round = 0; round < 2; round++) {
        uint32_t packed = s.triangle[t];
        double x[3][3], raised[3], k[3], d;
        int at = -1;
        for (int i = 0; i < 3; i++) {
            uint32_t number = i < S::dim ? corner(packed, i) : 0;
            place_in<S> a = vertex_place(s, number);
            at = i < S::dim && number == 0 ? i : at;
            raised[i] = square<S::dim>(a.x) - a.w;
            if (i < S::dim && number != 0 && !(square<S::dim>(a.x) + fabs(a.w) < limit)) {
                return open_sign;
            }
            for (int j = 0; j < 3; j++) {            /* p in place of the vertex at infinity */
                x[i][j] = i < S::dim && number == 0 ? p[j] : a.x[j];
            }
        }
        const double *a = x[0], *b = x[1], *c = x[2];
        if (S::dim == 3) {
            double u[3] = { b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0] };
            double q[3] = { p[1] * a[2] - p[2] * a[1], p[2] * a[0] - p[0] * a[2], p[0] * a[1] - p[1] * a[0] };
            d = a[0] * u[0] + a[1] * u[1] + a[2] * u[2];
            k[0] = p[0] * u[0] + p[1] * u[1] + p[2] * u[2];
            k[1] = c[0] * -q[0] + c[1] * -q[1] + c[2] * -q[2];
            k[2] = b[0] * q[0] + b[1] * q[1] + b[2] * q[2];
        } else {
            d = a[0] * b[1] - a[1] * b[0];
            k[0] = p[0] * b[1] - p[1] * b[0];
            k[1] = a[0] * p[1] - a[1] * p[0];
            k[2] = 0.0;
        }
        if (at >= 0) {
            if (d != 0.0 || round > 0) {
                return round > 0 ? open_sign : d > 0.0;
            }
            t = mate_of<S::dim>(s.triangle, count, packed, at);
            if (t < 0) {
                return open_sign;
            }
            continue;
        }
        double sum = raised[0] * k[0] + raised[1] * k[1] + (S::dim == 3 ? raised[2] * k[2] : 0.0) - d * lift;
        if (sum != 0.0) {
            return sum > 0.0;
        }
        double best[3] = { p[0], p[1], p[2] }, own = d - k[0] - k[1] - k[2], verdict = 0.0;
        for (int i = -1; i < S::dim; i++) {          /* v itself at first */
            double y[3] = { i < 0 ? 0.0 : x[i < 0 ? 0 : i][0], i < 0 ? 0.0 : x[i < 0 ? 0 : i][1],
                            i < 0 ? 0.0 : x[i < 0 ? 0 : i][2] }, coefficient = i < 0 ? own : k[i < 0 ? 0 : i];
            bool larger = y[0] != best[0] ? y[0] > best[0] : y[1] != best[1] ? y[1] > best[1]
                        : S::dim == 3 && y[2] > best[2];
            if (larger && coefficient != 0.0) {
                verdict = coefficient;
                for (int j = 0; j < 3; j++) {
                    best[j] = y[j];
                }
            }
        }
        return verdict > 0.0;
    }
    return open_sign;
}

/* The sphere of the facet (a, b, c), none being the vertex at infinity, and the answer for point p, by doubles. */
template <int DIM, bool WEIGHTED>
__device__ __noinline__ int refine(const space &all, uint32_t v, uint32_t a, uint32_t b, uint32_t c, uint32_t p,
                                   float4 *sphere)
{
    const record own = all.point[v];
    float4 q = sphere_of_triangle<DIM, WEIGHTED>(
        a != none, b != none, c != none, relative<DIM, double>(all, own, all.point[a != none ? a : v]),
        relative<DIM, double>(all, own, all.point[b != none ? b : v]),
        relative<DIM, double>(all, own, all.point[c != none ? c : v]), walls_of<DIM>(all, own));
    *sphere = q;
    return side(q, probe_of<DIM, WEIGHTED>(relative<DIM, double>(all, own, all.point[p])));
}

/* What floats leave open: is point id in conflict with triangle t?  A star in floats gets the sphere from doubles. */
template <int DIM, bool WEIGHTED, int NT, int NV, int SCRATCH>
__device__ inline int decide(star<DIM, WEIGHTED, NT, NV, SCRATCH, float> &s, const space &all, uint32_t v, int, int t,
                             uint32_t id, const place<float> &, pbw__digit *)
{
    uint32_t c[3] = { 1, 1, 1 };
    for (int k = 0; k < DIM; k++) {
        c[k] = corner(s.triangle[t], k);
    }
    return refine<DIM, WEIGHTED>(all, v, c[0] != 0 ? s.id[c[0]] : none, c[1] != 0 ? s.id[c[1]] : none,
                                 DIM == 3 && c[2] != 0 ? s.id[c[2]] : none, id, &s.sphere[t]);
}

/* The exact answer: is point id, at p relative to v, in conflict with triangle t? */
template <int DIM, bool WEIGHTED, int NT, int NV, int SCRATCH>
__device__ inline int decide(star<DIM, WEIGHTED, NT, NV, SCRATCH, double> &s, const space &all, uint32_t v, int count,
                             int t, uint32_t id, const place<double> &p, pbw__digit *pool)
{
    int hit = settle_on_grid(s, count, t, all.exact_height, p.x[0], p.x[1], p.x[2], p.w);
    return hit != open_sign ? hit : settle<DIM, WEIGHTED>(all, v, s.id, s.triangle, count, t, id, pool);
}

/* Finds the cavity of point id, at p relative to v, in the stars of those tiles that go, and makes the point a vertex
   of theirs; count: their triangles.  Without SETTLES what floats leave open stays open. */
template <int T, bool SETTLES, typename S>
__device__ inline int carve(S &s, const space &all, uint32_t v, bool go, uint32_t id, const place_in<S> &p, int count,
                            pbw__digit *pool, hole &cavity)
{
    typedef typename S::types types;
    typedef typename types::pair pair;
    typedef typename types::number number_type;
    const int words = S::vertices / 32, lane = (int)threadIdx.x & (T - 1);
    const unsigned below = lanes_below<T>();
    const probe float_p = probe_of<S::dim, S::weighted>(p);
    int conflicts = 0, edges = 0, result = 0;

    typedef typename types::rounds rounds_type;
    rounds_type hits = 0, opens = 0;                 /* bit i: triangle i T + lane */
    int rounds = (warp_max<T>(go ? count : 0) + T - 1) / T;
#pragma unroll(S::triangles / T < 8 ? S::triangles / T : 1)
    for (int i = 0; i < S::triangles / T; i++) {
        if (i == rounds) {
            break;
        }
        int t = i * T + lane, hit = go && t < count ? side(s.sphere[t], float_p) : 0;
        hits |= (rounds_type)(hit == 1) << i;
        opens |= (rounds_type)(hit == open_sign) << i;
    }
    if (any(opens != 0)) {
        bool undecided = !SETTLES && opens != 0;
        for (int i = 0; SETTLES && i < rounds; i++) {
            if ((opens >> i & 1) != 0) {
                int hit = decide(s, all, v, count, i * T + lane, id, p, pool);
                hits |= (rounds_type)(hit == 1) << i;
                undecided = undecided || hit == open_sign;
            }
        }
        result = tile_ballot<T>(undecided) != 0 ? star_open : 0;
    }
    for (int i = 0; i < rounds; i++) {
        unsigned vote = tile_ballot<T>((hits >> i & 1) != 0);
        if ((hits >> i & 1) != 0) {
            s.cavity[conflicts + __popc(vote & below)] = (number_type)(i * T + lane);
        }
        conflicts += __popc(vote);
    }
    if (conflicts == count && go) {
        result |= star_hidden;
    }
    go = go && conflicts > 0 && result == 0;
    const int conflict_end = warp_max<T>(go ? conflicts : 0);
    __syncwarp();

    /* the border: edges whose reverse is not in the cavity (in the plane: ends of the chain) */
    for (int base = 0; base < conflict_end; base += T) {
        if (go && base + lane < conflicts) {
            uint32_t t = s.triangle[s.cavity[base + lane]], a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
            if (S::dim == 3) {
                atomicOr(&s.matrix[a * words + (b >> 5)], 1u << (b & 31));
                atomicOr(&s.matrix[b * words + (c >> 5)], 1u << (c & 31));
                atomicOr(&s.matrix[c * words + (a >> 5)], 1u << (a & 31));
            } else {
                atomicOr(&s.matrix[a >> 5], 1u << (a & 31));
                atomicOr(&s.matrix[words + (b >> 5)], 1u << (b & 31));
            }
        }
    }
    __syncwarp();
    uint32_t number = none;
    for (int round = 0; round < 2; round++) {        /* a free number; at first among those never used */
        if (go && number == none) {
            for (int i = 0; i < words && number == none; i++) {
                uint32_t free = ~s.used[i];
                number = free != 0 ? (uint32_t)(i * 32 + __ffs((int)free) - 1) : none;
            }
        }
        if (!any(go && number == none)) {
            break;
        }
        find_used<T>(s, go && number == none, count);
    }
    if (go && number == none) {
        result |= star_full;
    }
    for (int base = 0; base < conflict_end; base += T) {
        uint32_t c[3] = { 0, 0, 0 };
        bool mine = go && base + lane < conflicts;
        if (mine) {
            uint32_t t = s.triangle[s.cavity[base + lane]];
            for (int k = 0; k < S::dim; k++) {
                c[k] = corner(t, k);
            }
        }
        for (int k = 0; k < S::dim; k++) {
            uint32_t a = c[k], b = c[k + 1 == S::dim ? 0 : k + 1];
            bool is_border = S::dim == 3 ? mine && (s.matrix[b * words + (a >> 5)] >> (a & 31) & 1) == 0
                           : mine && (k == 0 ? (s.matrix[words + (a >> 5)] >> (a & 31) & 1) == 0
                                             : (s.matrix[a >> 5] >> (a & 31) & 1) == 0);
            unsigned vote = tile_ballot<T>(is_border);
            int at = edges + __popc(vote & below);
            if (is_border && at < S::triangles + 4) {
                if (S::dim == 2) {                   /* (a, new) at the start of the chain, (new, a) at its end */
                    b = k == 0 ? number : a;
                    a = k == 0 ? a : number;
                }
                s.border[at] = (pair)((a & (S::vertices - 1)) << types::bits | (b & (S::vertices - 1)));
            }
            edges += __popc(vote);
        }
    }
    if (go && count - conflicts + edges > S::triangles) {
        result |= star_full;
    }
    __syncwarp();
    go = go && result == 0;
    for (int base = 0; base < conflict_end; base += T) {
        if (go && base + lane < conflicts) {
            uint32_t t = s.triangle[s.cavity[base + lane]], a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
            if (S::dim == 3) {
                s.matrix[a * words + (b >> 5)] = s.matrix[b * words + (c >> 5)] = s.matrix[c * words + (a >> 5)] = 0;
            } else {
                s.matrix[a >> 5] = s.matrix[words + (b >> 5)] = 0;
            }
        }
    }
    if (go && lane == 0) {
        set_vertex(s, number, id, p);
        s.used[number >> 5] |= 1u << (number & 31);
    }
    __syncwarp();
    cavity.conflicts = conflicts;
    cavity.edges = edges;
    cavity.number = number;
    return go ? star_changed : result;
}

/* Replaces the cavities of the tiles that go by the triangles from the first fans edges of their borders to the new
   vertex, and from the others to infinity; in the plane the border is the new edges.  The last loop must not
   decrement count and then move triangle[count].  In an insertion that is inlined, ptxas V13.0.88 for sm_90 takes the
   addresses from the old count, with offsets of -4 and -16 bytes, but gives the old and the new count one register
   and decrements that first: the simplex before the last one moves, and most of the zoo in cuda_test fails.
   tests/cuda_inline.cu has that loop alone. */
template <int T, typename S>
__device__ inline void fan(S &s, bool go, const hole &cavity, int fans, int &count, unsigned walls)
{
    typedef typename S::types types;
    const int lane = (int)threadIdx.x & (T - 1), conflicts = cavity.conflicts, edges = cavity.edges;
    const int edge_end = warp_max<T>(go ? edges : 0);
    for (int base = 0; base < edge_end; base += T) {
        int i = base + lane;
        if (go && i < edges) {
            uint32_t edge = s.border[i], a = edge >> types::bits, b = edge & ((1u << types::bits) - 1);
            uint32_t c = S::dim == 3 && i < fans ? cavity.number : 0;
            int slot = i < conflicts ? s.cavity[i] : count + i - conflicts;
            s.triangle[slot] = pack(a, b, c);
            s.sphere[slot] = sphere_of_triangle<S::dim, S::weighted>(a, b, c, vertex_place(s, a), vertex_place(s, b),
                                                                     vertex_place(s, c), walls);
        }
    }
    __syncwarp();
    for (int i = 1; any(go && i <= conflicts - edges); i++) {        /* fewer than before: the last fill the holes */
        if (go && i <= conflicts - edges && lane == 0) {
            const int at = s.cavity[conflicts - i], last = count - i;
            if (at != last) {
                s.triangle[at] = s.triangle[last];
                s.sphere[at] = s.sphere[last];
            }
        }
        __syncwarp();
    }
    count += go ? edges - conflicts : 0;
}

/* The star of v and the points a, b, c, one finite triangle and an infinite one on each of its edges, as the border
   of a hole that fan fills. */
template <int T, typename S> __device__ inline void start(S &s, bool go, const uint32_t *id, const place_in<S> *p)
{
    typedef typename S::types types;
    int lane = (int)threadIdx.x & (T - 1);
    if (go) {
        for (int i = lane; i < S::vertices * s.words; i += T) {
            s.matrix[i] = 0;
        }
        for (int i = lane; i < s.words; i += T) {
            s.used[i] = i == 0 ? (2u << S::dim) - 1 : 0;
        }
        if (lane < S::dim) {
            set_vertex(s, (uint32_t)lane + 1, id[lane], p[lane]);
        } else if (lane == S::dim) {
            set_infinity(s);
        }
    }
    __syncwarp();
    if (go && lane <= S::dim) {
        uint32_t a, b;
        if (S::dim == 3) {                           /* (1 2 3), (2 1 0), (3 2 0), (1 3 0) */
            a = lane == 0 ? 1 : lane == 3 ? 1 : (uint32_t)lane + 1;
            b = lane == 0 ? 2 : lane == 3 ? 3 : (uint32_t)lane;
        } else {                                     /* (1 2), (2 0), (0 1) */
            a = lane == 0 ? 1 : lane == 1 ? 2 : 0;
            b = lane == 0 ? 2 : lane == 1 ? 0 : 1;
        }
        s.border[lane] = (typename types::pair)(a << types::bits | b);
    }
    __syncwarp();
}

template <int DIM> __device__ inline hole first_hole()
{
    hole h = { 0, DIM + 1, 3 };
    return h;
}

/* Stores the finished stars of the tiles that go. */
template <int T, typename S> __device__ inline void finish(S &s, bool go, uint32_t v, int count, const store &out)
{
    int lane = (int)threadIdx.x & (T - 1), vertices = 0;
    find_used<T>(s, go, count);
    if (go) {
        if (lane == 0) {
            s.id[0] = none;
        }
        for (int i = 0; i < s.words; i++) {
            vertices += __popc(s.used[i]);
        }
        /* 0 is counted, but a star without infinite triangles does not store it */
    }
    bool closed = true;
    int owned = 0;
    __syncwarp();
    if (go) {
        for (int t = lane; t < count; t += T) {
            bool mine = true;
            for (int k = 0; k < S::dim; k++) {
                uint32_t c = corner(s.triangle[t], k);
                closed = closed && c != 0;
                mine = mine && c != 0 && s.id[c] > v;
            }
            owned += mine;
        }
    }
    closed = tile_ballot<T>(!closed) == 0;
    owned = tile_sum<T>(owned);
    unsigned long long at = 0;
    vertices -= closed;
    unsigned long long units = (unsigned long long)(1 + vertices + count + 3) / 4;
    if (go && lane == 0) {
        at = atomicAdd(out.used, units);
    }
    at = tile_read<T>(at, 0);
    if (go && at + units <= out.capacity) {
        uint32_t *word = out.word + at * 4;
        if (lane == 0) {
            word[0] = (uint32_t)count << 16 | (uint32_t)vertices;
            out.place[v - out.first] = (uint32_t)at;
            out.owned[v - out.first] = (uint32_t)owned;
        }
        for (int i = lane; i < S::vertices; i += T) {
            if (s.used[i >> 5] >> (i & 31) & 1 && (i > 0 || !closed)) {
                int rank = __popc(s.used[i >> 5] & ((1u << (i & 31)) - 1)) - closed;
                for (int j = 0; j < i >> 5; j++) {
                    rank += __popc(s.used[j]);
                }
                word[1 + rank] = s.id[i];
            }
        }
        for (int t = lane; t < count; t += T) {
            uint32_t packed = s.triangle[t] & verified;
            for (int k = 0; k < S::dim; k++) {
                uint32_t c = corner(s.triangle[t], k);
                int rank = __popc(s.used[c >> 5] & ((1u << (c & 31)) - 1)) - closed;
                for (uint32_t j = 0; j < c >> 5; j++) {
                    rank += __popc(s.used[j]);
                }
                packed |= (uint32_t)rank << (10 * k);
            }
            word[1 + vertices + t] = packed;
        }
    }
    __syncwarp();
}

__device__ inline void enqueue(const queue &q, bool put, uint32_t v)
{
    unsigned vote = __ballot_sync(all_lanes, put);
    uint32_t at = 0;
    int lane = (int)threadIdx.x & 31;
    if (lane == 0 && vote != 0) {
        at = atomicAdd(q.count, (uint32_t)__popc(vote));
    }
    at = __shfl_sync(all_lanes, at, 0);
    if (put) {
        q.vertex[at + (uint32_t)__popc(vote & lanes_below<32>())] = v;
    }
}

/* The determinant of three points relative to v: a fat corner is one whose sign needs no filter. */
template <int DIM, typename REAL>
__device__ inline REAL corner_size(const place<REAL> &a, const place<REAL> &b, const place<REAL> &c)
{
    return DIM == 3 ? c.x[0] * (a.x[1] * b.x[2] - a.x[2] * b.x[1]) + c.x[1] * (a.x[2] * b.x[0] - a.x[0] * b.x[2])
                      + c.x[2] * (a.x[0] * b.x[1] - a.x[1] * b.x[0])
                    : a.x[0] * b.x[1] - a.x[1] * b.x[0];
}

/* |a x b|^2 / (|a|^2 |b|^2) and |det|^2 / (|a|^2 |b|^2 |c|^2); 0 where there is a 0. */
template <typename REAL> __device__ inline float line_fatness(const place<REAL> &a, const place<REAL> &b)
{
    REAL x = a.x[1] * b.x[2] - a.x[2] * b.x[1], y = a.x[2] * b.x[0] - a.x[0] * b.x[2];
    REAL z = a.x[0] * b.x[1] - a.x[1] * b.x[0], size = square<3>(a.x) * square<3>(b.x);
    return size > sizes<REAL>::least() * sizes<REAL>::least() ? (float)((x * x + y * y + z * z) / size) : 0.0f;
}

template <int DIM, typename REAL>
__device__ inline float fatness(const place<REAL> &a, const place<REAL> &b, const place<REAL> &c)
{
    REAL d = corner_size<DIM>(a, b, c) * rsqrt(square<3>(a.x)) * rsqrt(square<3>(b.x));
    d *= DIM == 3 ? rsqrt(square<3>(c.x)) : 1;
    return d * d > 0 ? (float)(d * d) : 0.0f;
}

template <int T, typename REAL> __device__ inline place<REAL> tile_place(const place<REAL> &p, int lane)
{
    place<REAL> r;
    for (int k = 0; k < 3; k++) {
        r.x[k] = tile_read<T>(p.x[k], lane);
    }
    r.w = tile_read<T>(p.w, lane);
    return r;
}

/* Starts the stars of the tiles that go with points id, at p, of their own lanes, candidates being those of lanes
   below have, nearest first: fan is left to do.  Returns the lanes used, or 0 where no fat corner was found. */
template <int T, typename S>
__device__ inline unsigned start_from_lanes(S &s, bool go, uint32_t id, const place_in<S> &p, int have)
{
    int lane = (int)threadIdx.x & (T - 1);
    bool here = go && lane < have;
    place_in<S> a = tile_place<T>(p, 0), b;
    uint32_t ids[3];
    const float thin = 0.01f, flat = 1e-4f;
    unsigned vote = tile_ballot<T>(here && lane > 0 && line_fatness(a, p) > thin);
    int second = vote != 0 ? __ffs((int)vote) - 1 : 0, third = second;
    b = tile_place<T>(p, second);
    go = go && vote != 0;
    if (S::dim == 3) {
        const float fat = here && vote != 0 ? fatness<S::dim>(a, b, p) : 0.0f, most = -tile_min<T>(-fat);
        vote = tile_ballot<T>(fat > flat || (fat == most && fat > 1e-8f));
        third = vote != 0 ? __ffs((int)vote) - 1 : 0;
        go = go && vote != 0;
    }
    place_in<S> c = tile_place<T>(p, third), frame[3];
    ids[0] = tile_read<T>(id, 0);
    ids[1] = tile_read<T>(id, second);
    ids[2] = tile_read<T>(id, third);
    bool turn = corner_size<S::dim>(a, b, c) < 0;
    frame[0] = turn ? b : a;
    frame[1] = turn ? a : b;
    frame[2] = c;
    uint32_t swap = ids[turn ? 1 : 0];
    ids[1] = ids[turn ? 0 : 1];
    ids[0] = swap;
    start<T>(s, go, ids, frame);
    return go ? 1u | 1u << second | 1u << third : 0;
}

/* A box of the tree relative to v: v itself is rounded, and so are differences, to multiples of 2^-24 at most 2^1. */
struct span {
    float low[3], high[3];
};

template <int DIM> __device__ inline span relative_box(const box &b, const float *v)
{
    span r;
    for (int k = 0; k < 3; k++) {
        r.low[k] = k < DIM ? b.low[k] - v[k] - 4.8e-7f : 0.0f;
        r.high[k] = k < DIM ? b.high[k] - v[k] + 4.8e-7f : 0.0f;
    }
    return r;
}

/* A rough point relative to another, and the square of its distance; always the same operations, so that all passes
   over points agree on it. */
__device__ inline float rough_square(const float4 &p, const float *v, float *x)
{
    x[0] = __fsub_rn(p.x, v[0]);
    x[1] = __fsub_rn(p.y, v[1]);
    x[2] = __fsub_rn(p.z, v[2]);
    return __fmaf_rn(x[0], x[0], __fmaf_rn(x[1], x[1], __fmul_rn(x[2], x[2])));
}

/* The radius around q / 2 within which a point of the largest weight may be in conflict, grown by more than all
   roundings and by the error of the centre. */
template <bool WEIGHTED> __device__ inline float radius_of(float4 q, float heaviest)
{
    float size = root(fmaf(q.x, q.x, fmaf(q.y, q.y, q.z * q.z)));
    float radius = q.w < far_away ? fmaf(0.5f, size, slack * q.w) : 0.5f * q.w;
    return (WEIGHTED ? root(fmaf(radius, radius, heaviest)) : radius) * 1.00001f;
}

/* Bounds of the spheres of a star. */
template <int T, typename S> __device__ inline span reach_of(const S &s, bool go, int count, float heaviest)
{
    span r = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } };
    int lane = (int)threadIdx.x & (T - 1);
    if (go) {
        for (int t = lane; t < count; t += T) {
            float4 q = s.sphere[t];
            if (is_wall(q)) {
                continue;
            }
            float c[3] = { 0.5f * q.x, 0.5f * q.y, 0.5f * q.z }, radius = radius_of<S::weighted>(q, heaviest);
            for (int k = 0; k < S::dim; k++) {
                r.low[k] = fminf(r.low[k], c[k] - radius);
                r.high[k] = fmaxf(r.high[k], c[k] + radius);
            }
        }
    }
    for (int k = 0; k < S::dim; k++) {
        r.low[k] = tile_min<T>(r.low[k]) - 4.8e-7f;
        r.high[k] = 4.8e-7f - tile_min<T>(-r.high[k]);
    }
    return r;
}

/* Whether floats leave it open that point p is in conflict with some simplex of the star; all lanes of a tile go or
   none does, each with its own point.  The test is that of side, with the bound in the sum; a wall adds to it. */
template <int T, typename S> __device__ inline bool may_conflict(const S &s, bool go, int count, const place_in<S> &p)
{
    probe f = probe_of<S::dim, S::weighted>(p);
    float lift = fmaf(-1.25f, f.load, f.lift), size = -1.25f * f.size;
    bool may = false;
    int end = warp_max<T>(go ? count : 0), last = go ? count - 1 : 0;
#pragma unroll 4
    for (int t = 0; t < end; t++) {
        float4 q = s.sphere[t < last ? t : last];
        float least = fmaf(-q.x, f.x[0], fmaf(-q.y, f.x[1], fmaf(-q.z, f.x[2], fmaf(q.w, size, lift))));
        may = may || !(least > 0.0f);
    }
    return may && go;
}

/* ------------------------------------------------------------------------------------------------------
   >>near         The first rung: 8 lanes a star, candidates from the list of its group.
   1. Points within the start radius are collected and sorted by distance.  2. The nearest make the first corner, the
   others are inserted; all but the first 16 are screened first: a point in conflict with nothing now will never
   be, because stars only shrink.  3. The list is walked again for points outside the start radius and within the
   bounds of the spheres.  Both passes use the same float distance, so no point is met twice.  4. The star is
   certified if its spheres lie within the box that the list covers, or beyond the end of all points.  Of most inputs
   floats decide nearly everything, and a kernel without exact tests is quicker; the stars where they do not are built
   again by one that has them.  For points on surfaces (keeps) it ends after 2., keeps what it has, without the points
   that floats leave open, and certifies nothing.
   ------------------------------------------------------------------------------------------------------ */
const int near_triangles = 48, near_vertices = 32, near_points = 64, near_block = 128;
const int at_once = 2;                               /* groups whose points are loaded */

/* Blocks a multiprocessor, by what registers allow. */
template <int DIM, bool EXACT> struct near_blocks {
    static const int count = EXACT ? 4 : DIM == 2 ? 8 : 6;
};

template <int DIM, bool WEIGHTED, typename REAL>
using near_star = star<DIM, WEIGHTED, near_triangles, near_vertices, near_points, REAL>;

/* A launch of the first rung.  Without EXACT it builds total vertices from first on, each stride-th; with EXACT those
   of undecided. */
struct near_launch {
    space all;
    const box *group;
    const uint32_t *lists;
    const near_list *infos;
    uint32_t first, stride, total;
    bool keeps;
    store out;
    queue failed, undecided;
};

/* A star of the first rung while its tile builds it. */
template <int DIM, bool WEIGHTED, typename REAL> struct near_state {
    typedef REAL real;
    static const int dim = DIM;
    static const bool weighted = WEIGHTED;
    near_star<DIM, WEIGHTED, REAL> &s;
    const near_launch &a;
    const uint32_t *list;                            /* the groups near v */
    near_list info;
    record own;
    uint32_t v;
    int lane, length;
    float origin[3], heaviest;                       /* v; the largest weight relative to v's */
    unsigned walls;
    bool go, walking, changed;                       /* walking: step 3; changed: reach is out of date */
    float start2;                                    /* the square of the start radius */
    int have, cursor;                                /* points collected, and those of them already tried */
    int count, stored, position;                     /* triangles; points waiting; groups of the list read */
    uint32_t candidate, group_here;                  /* of each lane */
    unsigned pending, groups;                        /* lanes with a candidate to insert; with a group to read */
    place<REAL> p;                                   /* of the candidate */
    span reach;
};
const int near_lanes = 8;

/* Appends the points of the tile's group candidate closer than the start radius. */
template <typename N> __device__ __forceinline__ void collect_group(N &n, uint32_t group, bool here)
{
    uint32_t p = group * group_size + (uint32_t)n.lane;
    bool take = here && p < n.a.all.count && p != n.v;
    float d = 0.0f, x[3];
    if (take) {
        d = rough_square(n.a.all.rough[p], n.origin, x);
        take = d < n.start2;
    }
    unsigned takers = tile_ballot<near_lanes>(take);
    int at = n.have + __popc(takers & lanes_below<near_lanes>());
    if (take && at < near_points) {
        ((uint32_t *)n.s.sphere)[at] = p;            /* free before there is a star */
        n.s.scratch[at] = (__float_as_uint(d) & ~63u) | (uint32_t)at;
    }
    n.have += __popc(takers);
}

/* Step 1: the points within the start radius, which shrinks until there is room for them.  Stars whose points are too
   close for floats to tell apart are given up. */
template <typename N> __device__ __forceinline__ void collect_close(N &n)
{
    int shrinks = 0;
    for (bool again = n.go; any(again); shrinks++) {
        n.have = again ? 0 : n.have;
        for (int base = 0; any(again && base < (int)n.info.close); base += near_lanes) {
            uint32_t group = again && base + n.lane < n.length ? n.list[base + n.lane] : none;
            bool close = false;
            if (group != none) {
                span b = relative_box<N::dim>(n.a.group[group], n.origin);
                float d = 0.0f;
                for (int k = 0; k < N::dim; k++) {
                    float t = fmaxf(fmaxf(b.low[k], -b.high[k]), 0.0f);
                    d = fmaf(t, t, d);
                }
                close = d * 0.99999f < n.start2;
            }
            for (unsigned vote = tile_ballot<near_lanes>(close); any(vote != 0); vote &= vote - 1) {
                uint32_t from = tile_read<near_lanes>(group, vote != 0 ? __ffs((int)vote) - 1 : 0);
                collect_group(n, from, vote != 0);
            }
        }
        again = again && n.have > near_points;
        n.go = n.go && (!again || shrinks < 16);
        again = again && n.go;
        n.start2 = again ? n.start2 * 0.7f : n.start2;
        __syncwarp();
    }
}

/* Sorts the collected points by distance into scratch. */
template <typename N> __device__ __forceinline__ void sort_collected(N &n)
{
    const int T = near_lanes;
    uint32_t *sorted = n.s.scratch, *collected = (uint32_t *)n.s.sphere;
    uint32_t key[near_points / T], value[near_points / T];
    int before[near_points / T], most = warp_max<T>(n.go ? n.have : 0);
    for (int i = 0; i < near_points / T; i++) {
        bool mine = n.go && i * T + n.lane < n.have;
        key[i] = mine ? sorted[i * T + n.lane] : none;
        value[i] = mine ? collected[i * T + n.lane] : none;
        before[i] = 0;
    }
    for (int j = 0; j < most; j++) {
        uint32_t other = n.go && j < n.have ? sorted[j] : none;
        for (int i = 0; i < near_points / T; i++) {
            before[i] += other < key[i];
        }
    }
    __syncwarp();
    for (int i = 0; i < near_points / T; i++) {
        if (value[i] != none) {
            sorted[before[i]] = value[i];
        }
    }
    __syncwarp();
}

/* The next candidates that may be in conflict, until each tile has some or no more at hand. */
template <typename N> __device__ __forceinline__ void next_candidates(N &n)
{
    const int T = near_lanes;
    for (;;) {
        bool feed = n.go && n.pending == 0 && (n.walking ? n.stored > 0 : n.cursor < n.have);
        if (!any(feed)) {
            return;
        }
        int rest = n.walking ? n.stored : n.have - n.cursor, take = rest < T ? rest : T;
        __syncwarp();
        if (feed) {
            n.candidate = n.lane < take ? n.s.scratch[(n.walking ? n.stored - take : n.cursor) + n.lane] : none;
            n.stored -= n.walking ? take : 0;
        }
        n.p = candidate_place<N>(n.a.all, n.own, n.v, n.candidate);
        bool screened = n.walking || n.cursor >= 2 * T;
        bool may = may_conflict<T>(n.s, feed && screened, n.count, n.p) || !screened;
        unsigned vote = tile_ballot<T>(feed && n.candidate != none && may);
        n.pending = feed ? vote : n.pending;
        n.cursor += feed && !n.walking ? T : 0;
    }
}

/* The next 8 groups of the list that touch the reach of the star. */
template <typename N> __device__ __forceinline__ void next_groups(N &n, bool load)
{
    bool touches = false;
    if (load && n.position + n.lane < n.length) {
        n.group_here = n.list[n.position + n.lane];
        span b = relative_box<N::dim>(n.a.group[n.group_here], n.origin);
        touches = true;
        for (int k = 0; k < N::dim; k++) {
            touches = touches && b.low[k] <= n.reach.high[k] && b.high[k] >= n.reach.low[k];
        }
    }
    unsigned vote = tile_ballot<near_lanes>(touches);
    n.groups = load ? vote : n.groups;
    n.position += load ? near_lanes : 0;
}

/* Stores the points of several groups that are within the reach; several, to have several loads in flight. */
template <typename N> __device__ __forceinline__ void store_points(N &n, bool fill)
{
    const int T = near_lanes;
    uint32_t other[at_once];
    float4 place_of[at_once];
    for (int i = 0; i < at_once; i++) {
        bool is_there = fill && n.groups != 0;
        uint32_t from = tile_read<T>(n.group_here, is_there ? __ffs((int)n.groups) - 1 : 0);
        n.groups &= is_there ? n.groups - 1 : n.groups;
        other[i] = from * group_size + (uint32_t)n.lane;
        other[i] = is_there && other[i] < n.a.all.count && other[i] != n.v ? other[i] : none;
        place_of[i] = n.a.all.rough[other[i] != none ? other[i] : n.v];
    }
    for (int i = 0; i < at_once; i++) {
        float x[3];
        bool take = rough_square(place_of[i], n.origin, x) >= n.start2 && other[i] != none;
        for (int k = 0; k < N::dim; k++) {
            take = take && x[k] >= n.reach.low[k] && x[k] <= n.reach.high[k];
        }
        unsigned takers = tile_ballot<T>(take);
        if (take) {
            n.s.scratch[n.stored + __popc(takers & lanes_below<T>())] = other[i];
        }
        n.stored += __popc(takers);
    }
}

/* Step 3: walks on through the list, for all tiles of the block that have room. */
template <typename N> __device__ __forceinline__ void walk_list(N &n)
{
    n.walking = true;
    bool renew = n.go && n.changed;
    if (any(renew)) {
        span r = reach_of<near_lanes>(n.s, renew, n.count, n.heaviest);
        n.reach = renew ? r : n.reach;
        n.changed = n.changed && !renew;
    }
    __syncwarp();
    for (;;) {
        bool fill = n.go && n.stored <= near_points - at_once * near_lanes
                 && (n.groups != 0 || n.position < n.length);
        if (!any(fill)) {
            return;
        }
        bool load = fill && n.groups == 0;
        if (any(load)) {
            next_groups(n, load);
        }
        store_points(n, fill);
    }
}

/* Step 4: marks the simplices whose spheres lie within the box that the list covers; returns whether all do. */
template <typename N> __device__ __forceinline__ bool certify(N &n)
{
    const box b = n.a.group[n.v / group_size];
    span covered;
    for (int k = 0; k < 3; k++) {
        const float low = b.low[k] - n.info.reach, high = b.high[k] + n.info.reach;
        covered.low[k] = low <= 0.0f ? -HUGE_VALF : low - n.origin[k] + 4.8e-7f;
        covered.high[k] = high >= n.a.all.high[k] ? HUGE_VALF : high - n.origin[k] - 4.8e-7f;
    }
    bool certified = true;
    for (int t = n.lane; n.go && t < n.count; t += near_lanes) {
        float4 q = n.s.sphere[t];
        float c[3] = { 0.5f * q.x, 0.5f * q.y, 0.5f * q.z }, radius = radius_of<N::weighted>(q, n.heaviest);
        bool inside = true;
        for (int k = 0; k < N::dim; k++) {
            inside = inside && c[k] - radius > covered.low[k] && c[k] + radius < covered.high[k];
        }
        inside = inside || is_wall(q);
        n.s.triangle[t] |= inside && !n.a.keeps ? verified : 0;
        certified = certified && inside;
    }
    return tile_ballot<near_lanes>(!certified) == 0;
}

/* The vertex of a tile, with nothing collected yet. */
template <typename N> __device__ __forceinline__ void open_near(N &n, uint32_t v, bool valid)
{
    const space &all = n.a.all;
    const uint32_t row = v / group_size - n.a.out.first / group_size;
    const float4 rough = all.rough[v];
    n.v = v;
    n.own = all.point[v];
    n.list = n.a.lists + (size_t)row * list_size;
    n.info = n.a.infos[row];
    n.length = (int)n.info.length;
    n.lane = (int)threadIdx.x & (near_lanes - 1);
    n.origin[0] = rough.x, n.origin[1] = rough.y, n.origin[2] = rough.z;
    n.heaviest = N::weighted ? (float)((all.heaviest - n.own.c[N::dim]) * (all.unit * all.unit)) * 1.000001f : 0.0f;
    n.walls = walls_of<N::dim>(all, n.own);
    n.go = valid && n.length > 0 && *n.a.out.stop == 0;
    n.start2 = n.info.start * n.info.start;
    n.have = 0;
}

/* Step 2: the star of the nearest points that make a fat corner; the others are candidates. */
template <typename N> __device__ __forceinline__ void start_near(N &n)
{
    const int T = near_lanes;
    n.candidate = n.go && n.lane < n.have ? n.s.scratch[n.lane] : none;
    n.p = candidate_place<N>(n.a.all, n.own, n.v, n.candidate);
    const unsigned used = start_from_lanes<T>(n.s, n.go, n.candidate, n.p, n.have);
    n.go = n.go && used != 0;
    n.pending = n.go ? ((1u << (n.have < T ? n.have : T)) - 1) & ~used : 0;
    n.groups = 0;
    n.group_here = none;
    n.walking = false;
    n.changed = true;
    n.count = n.stored = 0;
    n.cursor = T;
    n.position = n.a.keeps ? n.length : 0;
    n.reach = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } };
}

template <int DIM, bool WEIGHTED, bool EXACT>
__global__ void __launch_bounds__(near_block, near_blocks<DIM, EXACT>::count)
near_kernel(const __grid_constant__ near_launch a)
{
    typedef rung_real<EXACT> REAL;
    typedef near_star<DIM, WEIGHTED, REAL> star_type;
    extern __shared__ float4 shared_words[];
    const int T = near_lanes;
    near_state<DIM, WEIGHTED, REAL> n = { ((star_type *)shared_words)[threadIdx.x / T], a };
    const uint32_t tile = (blockIdx.x * near_block + threadIdx.x) / T;
    const bool valid = tile < a.total;
    const uint32_t item = valid ? tile : a.total - 1;
    bool open = false, kept = false;
    open_near(n, EXACT ? a.undecided.vertex[item] : a.first + item * a.stride, valid);
    collect_close(n);
    sort_collected(n);
    start_near(n);
    for (bool starting = true;; starting = false) {
        if (!starting) {
            next_candidates(n);
        }
        if (__syncthreads_or(n.go && (starting || n.pending != 0)) == 0) {
            if (n.walking && __syncthreads_or(n.go && (n.groups != 0 || n.position < n.length)) == 0) {
                break;
            }
            walk_list(n);
            continue;
        }
        bool now = n.go && (starting || n.pending != 0);
        if (!any(now)) {
            continue;
        }
        hole cavity = first_hole<DIM>();
        int fans = 1;
        if (!starting) {
            int from = now ? __ffs((int)n.pending) - 1 : 0;
            n.pending &= n.pending - 1;
            uint32_t next = tile_read<T>(n.candidate, from);
            place<REAL> at = tile_place<T>(n.p, from);
            int result = carve<T, EXACT>(n.s, a.all, n.v, now, next, at, n.count, NULL, cavity);
            now = result == star_changed;
            fans = cavity.edges;
            n.changed = n.changed || now;
            open = open || (!EXACT && (result & star_open) != 0);
            kept = kept || (a.keeps && (result & star_full) != 0);
            n.go = n.go && (result & (a.keeps ? star_full : ~star_changed)) == 0;
        }
        fan<T>(n.s, now, cavity, fans, n.count, n.walls);
    }
    const bool certified = certify(n);
    finish<T>(n.s, n.go || kept, n.v, n.count, a.out);
    enqueue(a.failed, !a.keeps && valid && n.lane == 0 && !open && !(n.go && certified),
            n.v | (n.go ? stored_mark : 0));
    if (!EXACT) {
        enqueue(a.undecided, !a.keeps && valid && n.lane == 0 && open, n.v);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>far          The second and third rung: a warp or more a star, candidates from a search of the tree.
   The star is that of the first rung, or starts from the neighbours of v on the curve.  For each of its simplices
   that is not verified the tree is searched depth first for points in conflict with it; when there are none it is
   verified, which is final, because a simplex without conflicts is in the result.  So when all are, the star is
   certified whatever its size, and nothing is searched twice.  With t the point of a box where |x|^2 - q . x
   is least, axis by axis, and h = 2^-20 Q, for any x of the box

       |x|^2 - q . x - h |x|_1 >= sum over axes of t (t - q) - h |t| - h^2 / 4,

   because |x|^2 - q . x >= t (t - q) + (x - t)^2 on each axis and (x - t)^2 - h |x - t| >= -h^2 / 4.  A cap on the
   search keeps the total work linear.
   ------------------------------------------------------------------------------------------------------ */
/* Without shared memory stars live in scratch.  blocks: on a multiprocessor. */
template <int TRIANGLES, int WARPS, int BLOCKS, bool EXACT, bool SHARED> struct rung {
    static const int triangles = TRIANGLES, vertices = TRIANGLES / 2, warps = WARPS, blocks = BLOCKS;
    static const bool exact = EXACT, shared = SHARED;
};
typedef rung<128, 1, 24, false, true> quick_rung;
typedef rung<256, 8, 2, true, true> far_rung;
typedef rung<2048, 8, 2, true, false> last_rung;

/* What the warps of a star tell each other, behind their stacks. */
struct talk {
    int count, verdict, hand[8];                     /* hand: the simplex that a warp has in hand, or -1 */
    uint32_t waits[8];                               /* whether a warp has points to insert */
    int changed;
};

template <int DIM, bool WEIGHTED, typename RUNG>
using far_star = star<DIM, WEIGHTED, RUNG::triangles, RUNG::vertices,
                      RUNG::warps * stack_size + (int)(sizeof(talk) / sizeof(uint32_t)), rung_real<RUNG::exact> >;

template <int WARPS> __device__ inline void meet()
{
    if (WARPS == 1) {
        __syncwarp();
    } else {
        __syncthreads();
    }
}

/* Whether a simplex of the star, not a wall, may be in conflict with a point in a box. */
template <int DIM, bool WEIGHTED>
__device__ inline bool box_may_conflict(const float4 &sphere, const span &b, float weight)
{
    float q[3] = { sphere.x, sphere.y, sphere.z }, size = sphere.w, sum = 0.0f, squares = 0.0f, ones = 0.0f;
    bool infinite = size >= far_away;
    float h = infinite ? 0.0f : slack * size;
    for (int k = 0; k < DIM; k++) {
        float at = infinite ? (q[k] > 0.0f ? b.high[k] : b.low[k]) : fminf(fmaxf(0.5f * q[k], b.low[k]), b.high[k]);
        sum += infinite ? -at * q[k] : at * (at - q[k]);
        squares = fmaf(at, at, squares);
        ones += infinite ? fmaxf(fabsf(b.low[k]), fabsf(b.high[k])) : fabsf(at);
    }
    sum -= infinite || !WEIGHTED ? 0.0f : weight;
    squares = infinite ? 0.0f : squares + (WEIGHTED ? fabsf(weight) : 0.0f);
    return !(sum > 2.0f * slack * (squares + size * ones) + h * h);
}

/* The largest weight in a box relative to v's, rounded up. */
template <bool WEIGHTED> __device__ inline float relative_weight(const box &b, double own_weight)
{
    return WEIGHTED ? b.weight - (float)own_weight + slack * fabsf((float)own_weight) : 0.0f;
}

/* Four points that span the space: the first point, and in turn the one farthest from the span of those before. */
template <int DIM> __global__ void seed_kernel(const __grid_constant__ space s, int found, unsigned long long *seed)
{
    unsigned long long best = 0;
    record r[3];
    place<double> base[2];
    for (int i = 0; i < found; i++) {
        r[i] = s.point[i == 0 ? 0 : (uint32_t)seed[i]];
    }
    for (int i = 1; i < found; i++) {
        base[i - 1] = relative<DIM, double>(s, r[0], r[i]);
    }
    for (size_t i = thread_number(); i < s.count; i += (size_t)gridDim.x * blockDim.x) {
        place<double> p = relative<DIM, double>(s, r[0], s.point[i]);
        double d = found == 1 ? square<3>(p.x)
                 : found == 2 ? line_fatness(base[0], p) * square<3>(p.x) : fabs(corner_size<3>(base[0], base[1], p));
        best = max(best, (unsigned long long)__float_as_uint((float)d) << 32 | i);
    }
    best = tile_max<32>(best);
    if ((threadIdx.x & 31) == 0) {
        atomicMax(&seed[found], best);
    }
}

/* Starts a star from the points of the warp's lanes where start_from_lanes cannot: the nearest and two that, with v,
   come nearest to spanning the space, among them four seeds that do span it. */
template <typename S>
__device__ inline bool start_from_seeds(S &s, const space &all, uint32_t v, uint32_t id, const place_in<S> &p,
                                        bool here, pbw__digit *pool)
{
    int lane = (int)threadIdx.x & 31, second, third;
    place_in<S> a = tile_place<32>(p, 0), b, c, frame[3];
    uint32_t ids[3];
    float fat = here && lane > 0 ? line_fatness(a, p) : 0.0f, best = -tile_min<32>(-fat);
    second = __ffs((int)__ballot_sync(all_lanes, fat == best)) - 1;
    b = tile_place<32>(p, second);
    third = second;
    if (!(best > 1e-6f)) {
        return false;
    }
    if (S::dim == 3) {
        fat = here ? fatness<S::dim>(a, b, p) : 0.0f;
        best = -tile_min<32>(-fat);
        third = __ffs((int)__ballot_sync(all_lanes, fat == best)) - 1;
        if (!(best > 0.0f)) {
            return false;
        }
    }
    c = tile_place<32>(p, third);
    ids[0] = __shfl_sync(all_lanes, id, 0);
    ids[1] = __shfl_sync(all_lanes, id, second);
    ids[2] = __shfl_sync(all_lanes, id, third);
    const double *row[4] = { all.point[v].c, all.point[ids[0]].c, all.point[ids[1]].c, all.point[ids[2]].c };
    int sign = pbw__orient_in(pool, S::dim, row, &all.grid);
    if (sign == 0 || sign == PBW__OPEN) {
        return false;
    }
    frame[0] = sign < 0 ? b : a;
    frame[1] = sign < 0 ? a : b;
    frame[2] = c;
    uint32_t swap = ids[sign < 0 ? 1 : 0];
    ids[1] = ids[sign < 0 ? 0 : 1];
    ids[0] = swap;
    start<32>(s, true, ids, frame);
    return true;
}

/* Inserts a point into the star of a warp. */
template <typename S>
__device__ inline int insert(S &s, const space &all, uint32_t v, uint32_t id, const place_in<S> &p, int &count,
                             unsigned walls, pbw__digit *pool)
{
    hole cavity;
    int result = carve<32, true>(s, all, v, true, id, p, count, pool, cavity);
    fan<32>(s, result == star_changed, cavity, cavity.edges, count, walls);
    return result;
}

/* A star of v from 28 points at growing distances along the curve, so that it is bounded in all directions from the
   start; false if they and, with EXACT, the seeds span no simplex. */
template <bool EXACT, typename S>
__device__ inline bool start_on_curve(S &s, const space &all, const unsigned long long *seed, uint32_t v,
                                      const record &own, unsigned walls, pbw__digit *pool, uint32_t &candidate,
                                      place_in<S> &p, int &count)
{
    const int lane = (int)threadIdx.x & 31;
    uint32_t *order = s.scratch;
    int step = lane / 2 + 1;
    float far = step <= 6 ? (float)step : 6.0f * powf((float)all.count / 12.0f, (float)(step - 6) / 8.0f);
    uint32_t offset = (uint32_t)far + (step > 6 ? 1 : 0);
    candidate = none;
    if (lane < 28) {
        candidate =
            (lane & 1) != 0 ? (v + offset < all.count ? v + offset : none) : (offset <= v ? v - offset : none);
    }
    p = candidate_place<S>(all, own, v, candidate);
    uint32_t key = candidate != none ? (__float_as_uint((float)square<S::dim>(p.x)) & ~31u) | (uint32_t)lane : none;
    int before = 0, have = __popc(__ballot_sync(all_lanes, candidate != none));
    for (int i = 0; i < 32; i++) {
        before += __shfl_sync(all_lanes, key, i) < key;
    }
    order[lane] = none;
    __syncwarp();
    if (candidate != none) {
        order[before] = candidate;
    }
    __syncwarp();
    candidate = order[lane];
    __syncwarp();
    p = candidate_place<S>(all, own, v, candidate);
    bool started = start_from_lanes<32>(s, true, candidate, p, have) != 0;
    if (!started && EXACT) {
        if (candidate == none) {
            uint32_t other = lane - have > S::dim ? none : lane == have ? 0 : (uint32_t)seed[lane - have];
            candidate = other == v ? none : other;
            p = candidate_place<S>(all, own, v, candidate);
        }
        started = start_from_seeds(s, all, v, candidate, p, candidate != none, pool);
    }
    fan<32>(s, started, first_hole<S::dim>(), 1, count, walls);
    return started;
}

/* The stars of the tiles that go as the store has them. */
template <int T, typename S>
__device__ inline void start_from_store(S &s, bool go, const space &all, const store &in, uint32_t v,
                                        const record &own, unsigned walls, int &count)
{
    const int lane = (int)threadIdx.x & (T - 1);
    const uint32_t *word = in.word + (go ? (size_t)in.place[v - in.first] * 4 : 0);
    uint32_t vertices = word[0] & 0xffff, first = word[1] == none ? 0 : 1;
    count = go ? (int)(word[0] >> 16) : count;
    if (go) {
        for (int i = lane; i < S::vertices * s.words; i += T) {
            s.matrix[i] = 0;
        }
        for (uint32_t i = (uint32_t)lane; i < (uint32_t)s.words; i += T) {
            uint32_t rest = vertices + first > i * 32 ? vertices + first - i * 32 : 0;
            s.used[i] = rest >= 32 ? ~0u : (1u << rest) - 1;
        }
        if (lane == 0) {
            set_infinity(s);
        }
        for (uint32_t i = (uint32_t)lane; i < vertices; i += T) {
            uint32_t id = word[1 + i];
            if (id != none) {
                set_vertex(s, i + first, id, relative<S::dim, typename S::real>(all, own, all.point[id]));
            }
        }
    }
    __syncwarp();
    if (go) {
        for (int t = lane; t < count; t += T) {
            uint32_t packed = word[1 + vertices + (uint32_t)t], c[3] = { 0, 0, 0 };
            for (int k = 0; k < S::dim; k++) {
                c[k] = corner(packed, k) + first;
            }
            s.triangle[t] = pack(c[0], c[1], c[2]) | (packed & verified);
            s.sphere[t] = sphere_of_triangle<S::dim, S::weighted>(
                c[0], c[1], c[2], vertex_place(s, c[0]), vertex_place(s, c[1]), vertex_place(s, c[2]), walls);
        }
    }
    __syncwarp();
}

enum { far_busy, far_certified, far_hidden, far_lost, far_capped };

/* A launch of the second or third rung: total stars of work, each with at most cap looks.  After more than limit
   failures the remaining stars are not tried.  Without shared memory stars live in scratch. */
struct far_launch {
    space all;
    tree boxes;
    const unsigned long long *seed;
    queue work;
    uint32_t total, limit;
    int cap;
    void *scratch;
    pbw__digit *pool;
    store out;
    queue failed, large;
};

struct far_task {                                    /* resume: the store holds what was found so far */
    uint32_t v;
    bool resume;
    pbw__digit *pool;
};

/* One star, by all warps of a block: each searches for conflicts of its own simplex, then they insert in turns.
   changed: whether the star differs from the stored one. */
template <bool EXACT, int WARPS, typename S>
__device__ inline int far_star_of(S &s, const far_launch &a, const far_task &task, int &count, bool &changed)
{
    const space &all = a.all;
    const tree &boxes = a.boxes;
    const store &in = a.out;
    const uint32_t v = task.v;
    const int cap = a.cap;
    pbw__digit *const pool = task.pool;
    const int lane = (int)threadIdx.x & 31, warp = (int)threadIdx.x / 32;
    const unsigned below = lanes_below<32>();
    const record own = all.point[v];
    uint32_t *stack = s.scratch + warp * stack_size;
    talk &shared = *(talk *)(s.scratch + WARPS * stack_size);
    const float4 rough = all.rough[v];
    const float origin[3] = { rough.x, rough.y, rough.z };
    const unsigned walls = walls_of<S::dim>(all, own);
    const double own_weight = (own.c[S::dim] - all.heaviest) * (all.unit * all.unit);
    uint32_t candidate = none, word = 0, node = 0;
    place_in<S> p;
    unsigned pending = 0, hit = 0;                   /* lanes with a candidate to insert, with a group to search */
    int depth = 0, spent = 0, t = -1;                /* t: the simplex in hand, word: its triangle */

    count = 0;
    if (warp == 0) {
        bool started = true;
        if (task.resume) {
            start_from_store<32>(s, true, all, in, v, own, walls, count);
        } else {
            started = start_on_curve<EXACT>(s, all, a.seed, v, own, walls, pool, candidate, p, count);
            pending = started ? __ballot_sync(all_lanes, candidate != none) : 0;
        }
        if (lane == 0) {
            shared.count = count;
            shared.verdict = started ? far_busy : far_lost;
            shared.changed = !task.resume;
        }
    }
    meet<WARPS>();
    for (;;) {
        for (int turn = 0; turn < WARPS; turn++) {   /* points are inserted */
            if (WARPS > 1) {
                if (lane == 0 && turn == 0) {
                    shared.waits[warp] = pending;
                }
                __syncthreads();
                if (shared.waits[turn] == 0) {
                    continue;
                }
            }
            if (turn == warp && pending != 0 && shared.verdict == far_busy) {
                count = shared.count;
                if (t >= 0 && (t >= count || s.triangle[t] != word)) {
                    pending = 0;                     /* another warp has changed its simplex */
                }
                int verdict = far_busy;
                bool touched = false;
                while (pending != 0 && verdict == far_busy) {
                    bool waits = (pending >> lane & 1) != 0;     /* the nearest first */
                    float length = waits ? (float)square<S::dim>(p.x) : HUGE_VALF, least = tile_min<32>(length);
                    int from = __ffs((int)(__ballot_sync(all_lanes, length == least) & pending)) - 1;
                    pending &= ~(1u << from);
                    uint32_t next = __shfl_sync(all_lanes, candidate, from);
                    place_in<S> at = tile_place<32>(p, from);
                    bool known = false;              /* the vertices of the star come by again in the search */
                    for (int i = lane; i < S::vertices; i += 32) {
                        known = known || (i > 0 && (s.used[i >> 5] >> (i & 31) & 1) != 0 && s.id[i] == next);
                    }
                    if (any(known)) {
                        continue;
                    }
                    int result = insert(s, all, v, next, at, count, walls, pool);
                    verdict = S::weighted && result == star_hidden ? far_hidden
                            : (result & ~star_changed) != 0 ? far_lost : far_busy;
                    if (result == star_changed) {
                        touched = true;
                        pending = __ballot_sync(all_lanes,
                                                may_conflict<32>(s, true, count, p) && (pending >> lane & 1) != 0);
                    }
                    spent += 4;
                }
                __syncwarp();
                if (lane == 0) {
                    shared.count = count;
                    shared.verdict = verdict;
                    shared.changed = shared.changed || touched;
                }
                __syncwarp();
            }
        }
        meet<WARPS>();
        count = shared.count;
        changed = shared.changed != 0;
        if (shared.verdict != far_busy) {
            return shared.verdict;
        }
        pending = 0;
        if (t >= count || (t >= 0 && s.triangle[t] != word)) {      /* it is gone */
            t = -1;
        }
        if (WARPS > 1) {
            if (lane == 0) {
                shared.hand[warp] = t;
            }
            __syncthreads();
        }
        if (t < 0) {                                 /* another simplex, that no warp has in hand */
            int skip = 0;
            for (int w = 0; w < warp; w++) {
                skip += shared.hand[w] < 0;
            }
            for (int base = 0; base < count && t < 0; base += 32) {
                bool open = base + lane < count && (s.triangle[base + lane] & verified) == 0;
                for (int w = 0; w < WARPS && WARPS > 1; w++) {
                    open = open && shared.hand[w] != base + lane;
                }
                unsigned vote = __ballot_sync(all_lanes, open);
                for (; skip > 0 && vote != 0; skip--) {
                    vote &= vote - 1;
                }
                t = vote != 0 ? base + __ffs((int)vote) - 1 : -1;
            }
            if (t >= 0) {
                word = s.triangle[t];
                depth = is_wall(s.sphere[t]) ? 0 : 1;
                hit = 0;
                if (lane == 0) {
                    stack[0] = (uint32_t)boxes.levels << 29;
                }
                __syncwarp();
            }
        }
        if (WARPS == 1 ? t < 0 : __syncthreads_and(t < 0) != 0) {
            return far_certified;
        }
        while (t >= 0 && pending == 0 && spent <= cap && (hit != 0 || depth > 0)) {
            spent++;
            if ((spent & 63) == 0 && *in.stop != 0) {
                spent = cap + 1;
            }
            if (hit != 0) {                          /* the points of 4 groups */
                uint32_t group = none;
                for (int i = 0; i < 4; i++) {
                    group = lane / 8 == i && hit != 0 ? node + (uint32_t)__ffs((int)hit) - 1 : group;
                    hit &= hit - 1;
                }
                candidate = group != none ? group * group_size + (uint32_t)(lane & 7) : none;
                candidate = candidate < all.count && candidate != v ? candidate : none;
                for (int k = 0; k < S::dim; k++) {
                    candidate = corner(word, k) != 0 && s.id[corner(word, k)] == candidate ? none : candidate;
                }
                p = candidate_place<S>(all, own, v, candidate);
                int answer = candidate != none ? side(s.sphere[t], probe_of<S::dim, S::weighted>(p)) : 0;
                if (EXACT && answer == open_sign) {  /* a flat simplex on the hull leaves many points open */
                    answer = decide(s, all, v, count, t, candidate, p, NULL);
                }
                pending = __ballot_sync(all_lanes, answer != 0);
            } else {                                 /* 32 boxes: those that matter wait, the nearest on top */
                uint32_t top = stack[--depth], level = (top >> 29) - 1, child;
                float distance = HUGE_VALF;
                bool visit = false;
                node = (top & 0x1fffffffu) * 32;
                child = node + (uint32_t)lane;
                if (child < boxes.size[level]) {
                    box b = boxes.level[level][child];
                    span r = relative_box<S::dim>(b, origin);
                    visit = box_may_conflict<S::dim, S::weighted>(s.sphere[t], r,
                                                                  relative_weight<S::weighted>(b, own_weight));
                    distance = 0.0f;
                    for (int k = 0; k < S::dim && visit; k++) {
                        float d = fmaxf(fmaxf(r.low[k], -r.high[k]), 0.0f);
                        distance = fmaf(d, d, distance);
                    }
                    distance = visit ? distance : HUGE_VALF;
                }
                __syncwarp();
                unsigned vote = __ballot_sync(all_lanes, visit);
                if (level == 0) {
                    hit = vote;
                } else {
                    float least = tile_min<32>(distance);
                    unsigned nearest = __ballot_sync(all_lanes, visit && distance == least);
                    nearest &= ~nearest + 1;         /* one of them */
                    if (visit) {
                        unsigned others = vote & ~nearest;
                        stack[depth + __popc(others & ((nearest >> lane & 1) != 0 ? all_lanes : below))] =
                            level << 29 | child;
                    }
                    depth += __popc(vote);
                    __syncwarp();
                }
            }
        }
        meet<WARPS>();                               /* all have read the star */
        if (lane == 0 && t >= 0 && spent > cap) {
            shared.verdict = far_capped;
        } else if (lane == 0 && t >= 0 && pending == 0) {       /* no point is in conflict with it */
            s.triangle[t] = word | verified;
        }
        t = pending != 0 ? t : -1;
        meet<WARPS>();
    }
}

/* A star in shared memory, a block each; else in scratch, and blocks take vertices in turn.
   Only the warp that inserts calls the exact stages, so one pool serves a block. */
template <int DIM, bool WEIGHTED, typename RUNG>
__global__ void __launch_bounds__(32 * RUNG::warps, RUNG::blocks)
far_kernel(const __grid_constant__ far_launch a)
{
    typedef far_star<DIM, WEIGHTED, RUNG> star_type;
    extern __shared__ float4 shared_words[];
    star_type &s = *(RUNG::shared ? (star_type *)shared_words : (star_type *)a.scratch + blockIdx.x);
    pbw__digit *digits = a.pool == NULL ? NULL : a.pool + (blockIdx.x * 32 + (threadIdx.x & 31)) * (size_t)PBW__POOL;
    __shared__ bool ends;
    for (uint32_t i = blockIdx.x; i < a.total; i += gridDim.x) {
        uint32_t entry = a.work.vertex[i], v = entry & ~stored_mark;
        bool resume = entry != v && a.out.place[v - a.out.first] != none, changed;      /* none: the store was full */
        int count = 0;
        if (threadIdx.x == 0) {
            ends = *(volatile uint32_t *)a.failed.count > a.limit || *a.out.stop != 0;
        }
        meet<RUNG::warps>();
        if (ends) {
            return;
        }
        int verdict =
            far_star_of<RUNG::exact, RUNG::warps>(s, a, far_task{ v, resume, digits }, count, changed);
        if (threadIdx.x < 32) {
            bool fails = verdict == far_lost || verdict == far_capped, stays = verdict != far_lost;
            if (verdict == far_capped || (verdict == far_certified && changed)) {
                finish<32>(s, true, v, count, a.out);
            }
            if (verdict == far_hidden && threadIdx.x == 0) {
                a.out.place[v - a.out.first] = hidden;
                a.out.owned[v - a.out.first] = 0;
            }
            enqueue(a.failed, fails && threadIdx.x == 0, stays ? v | stored_mark : entry);
            enqueue(a.large, verdict == far_certified && threadIdx.x == 0, v);
        }
        meet<RUNG::warps>();
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>wide         The rungs for points on surfaces: all simplices of a star search at once.
   Where points lie on a surface most spheres are large and hug it: a box along the axes of space touches them
   wherever the surface is aslant, and a search for each simplex alone meets the same boxes again and again.  So here
   one search serves all simplices of a star, in a tree of bricks: boxes along the axes of their own points, on a
   surface as thin as its noise.  Let m be the middle of a brick relative to v, e_j its axes, h_j how far its points
   are from m along them, and g = q - 2m.  A point m + y of it is in conflict with a simplex only if this is above 0:

       q . (m + y) - |m + y|^2 = q . m - |m|^2 + g . y - |y|^2
                              <= q . m - |m|^2 + sum over axes of t (|g . e_j| - t),     t = min(|g . e_j| / 2, h_j).

   Errors, with f = 2^-24 and B the sum of all |m_k| and h_j, beyond which no point of the brick is: q is off by
   16 f Q; m, rounded to floats, by f |m|; the axes are those of Jacobi's method, rounded, and the cross product of
   two: of length 1, and at right angles, but for 8 f, as far as y is concerned; products and sums, 10 f.  In all that
   is less than 40 f (Q B + B^2), and 48 f = 3 2^-20 is taken.  For infinite simplices |m|^2 and |y|^2 do not count
   (>>sphere).

   What lies below a sphere by d, divided by Q |p|^2, is how much more bent the sphere through p would be that has
   the direction of q; so points of which it is largest make the star small soonest, and bricks that may have such are
   searched first.
   ------------------------------------------------------------------------------------------------------ */
/* A box along the axes of its points, of 8 points or 8 boxes: its middle, two of its axes (the third is their cross
   product), and how far points are from the middle along each axis; all in units. */
struct alignas(16) brick {
    double middle[3];
    float axis[2][3], half[3], unused;
};

struct moments {                                     /* of the points of a brick; spread: around the mean */
    double mean[3], spread[3][3];
};

const int brick_levels = 9;
typedef tree_of<brick, brick_levels> brick_tree;

/* The bricks of a level, of 8 points or of 8 bricks: all but how far their points are. */
__global__ void brick_kernel(const __grid_constant__ space s, const moments *child, uint32_t children, moments *own,
                             brick *out, uint32_t size)
{
    size_t g = thread_number();
    if (g < size) {
        const uint32_t first = (uint32_t)g * 8, end = children - first < 8 ? children : first + 8;
        const double part = 1.0 / (double)(end - first);
        moments m = {};
        double turn[3][3] = { { 1.0, 0.0, 0.0 }, { 0.0, 1.0, 0.0 }, { 0.0, 0.0, 1.0 } };
        double(&a)[3][3] = m.spread;
        brick b;
        for (int pass = 0; pass < 2; pass++) {
            for (uint32_t i = first; i < end; i++) {
                double x[3];
                for (int k = 0; k < 3; k++) {
                    x[k] = child == NULL ? in_units(s, s.point[i], k) : child[i].mean[k];
                    m.mean[k] += pass == 0 ? x[k] * part : 0.0;
                    x[k] -= m.mean[k];
                }
                for (int k = 0; k < 9 && pass > 0; k++) {
                    const double within = child == NULL ? 0.0 : child[i].spread[k / 3][k % 3];
                    a[k / 3][k % 3] += (x[k / 3] * x[k % 3] + within) * part;
                }
            }
        }
        own[g] = m;
        for (int round = 0; round < 15; round++) {   /* Jacobi's method: turns that make entries 0, one by one */
            const int i = round % 3 == 2 ? 1 : 0, j = round % 3 == 0 ? 1 : 2;
            const double difference = a[j][j] - a[i][i], twice = 2.0 * a[i][j];
            if (twice == 0.0) {
                continue;
            }
            const double t = (difference < 0.0 ? -1.0 : 1.0) * twice
                           / (fabs(difference) + sqrt(difference * difference + twice * twice));
            const double cosine = rsqrt(t * t + 1.0), sine = t * cosine;
            for (int k = 0; k < 3; k++) {
                const double x = a[k][i], y = a[k][j];
                a[k][i] = cosine * x - sine * y;
                a[k][j] = sine * x + cosine * y;
            }
            for (int k = 0; k < 3; k++) {
                const double x = a[i][k], y = a[j][k], u = turn[i][k], w = turn[j][k];
                a[i][k] = cosine * x - sine * y;
                a[j][k] = sine * x + cosine * y;
                turn[i][k] = cosine * u - sine * w;
                turn[j][k] = sine * u + cosine * w;
            }
        }
        for (int k = 0; k < 3; k++) {
            b.middle[k] = m.mean[k];
            b.axis[0][k] = (float)turn[0][k];
            b.axis[1][k] = (float)turn[1][k];
            b.half[k] = 0.0f;
        }
        b.unused = 0.0f;
        out[g] = b;
    }
}

__device__ inline void third_axis(const brick &b, float *axis)
{
    const float *u = b.axis[0], *w = b.axis[1];
    axis[0] = u[1] * w[2] - u[2] * w[1];
    axis[1] = u[2] * w[0] - u[0] * w[2];
    axis[2] = u[0] * w[1] - u[1] * w[0];
}

/* How far points are: a thread a point. */
__global__ void half_kernel(const __grid_constant__ space s, const __grid_constant__ brick_tree t)
{
    const size_t i = thread_number() < s.count ? thread_number() : s.count - 1;
    const record r = s.point[i];
    size_t above = i / 8;
    for (int level = 0; level < t.levels; level++, above /= 8) {
        brick &b = ((brick *)t.level[level])[above];
        float last[3];
        double d[3] = { 0.0, 0.0, 0.0 };
        third_axis(b, last);
        for (int k = 0; k < 3; k++) {
            const double x = in_units(s, r, k) - b.middle[k];
            d[0] += x * (double)b.axis[0][k];
            d[1] += x * (double)b.axis[1][k];
            d[2] += x * (double)last[k];
        }
        for (int k = 0; k < 3; k++) {
            int reach = __float_as_int(__double2float_ru(fabs(d[k]) + 2e-15));
            reach = level == 0 ? tile_max<8>(reach) : tile_max<32>(reach);   /* above, a warp's points are in one */
            if ((threadIdx.x & (level == 0 ? 7 : 31)) == 0) {
                atomicMax((int *)&b.half[k], reach);
            }
        }
    }
}

/* Stars in shared memory, or in scratch.  What a rung has no room for goes on to the next.  room: for bricks that
   wait. */
template <int TRIANGLES, int BLOCKS, int ROOM, bool SHARED>
struct wide_rung_of : rung<TRIANGLES, 1, BLOCKS, true, SHARED> {
    static const int room = ROOM;
};
typedef wide_rung_of<128, 16, 448, true> wide_rung;
typedef wide_rung_of<512, 5, 1024, true> large_wide_rung;
typedef wide_rung_of<2048, 5, 8192, false> last_wide_rung;

const int group_room = 36;                           /* for groups, of which 4 are searched as soon as they wait */

template <typename RUNG> struct wide_star {
    typedef star<3, false, RUNG::triangles, RUNG::vertices, RUNG::room + group_room,
                 rung_real<RUNG::exact> > type;
    type s;                                          /* scratch: bricks that wait, levels << 28 | number; groups */
    float inverse[RUNG::triangles];                  /* 1 / Q, or 0: no point that matters is in conflict with it */
    uint16_t depth[RUNG::room];                      /* of bricks that wait, half of a float */
};

/* How deep a brick may reach into the spheres of a star. */
template <typename STAR>
__device__ inline float depth_of_brick(const STAR &w, int count, const brick &b, const double *v)
{
    float depth = 0.0f, m[3], last[3], ones = 0.0f, square_m = 1e-30f;
    for (int k = 0; k < 3; k++) {
        m[k] = (float)(b.middle[k] - v[k]);
        square_m = fmaf(m[k], m[k], square_m);
        ones += fabsf(m[k]) + b.half[k];
    }
    third_axis(b, last);
    const float squares = 3.0f * slack * ones * ones - square_m, x = m[0] + m[0], y = m[1] + m[1], z = m[2] + m[2];
    ones *= 3.0f * slack;
#pragma unroll 2
    for (int t = 0; t < count; t++) {
        const float4 q = w.s.sphere[t];
        const float g[3] = { q.x - x, q.y - y, q.z - z };
        const float along[3] = { fabsf(dot(g, b.axis[0])), fabsf(dot(g, b.axis[1])), fabsf(dot(g, last)) };
        float below = fmaf(q.x, m[0], fmaf(q.y, m[1], fmaf(q.z, m[2], fmaf(fabsf(q.w), ones, squares))));
        for (int k = 0; k < 3; k++) {
            const float at = fminf(0.5f * along[k], b.half[k]);
            below = fmaf(at, along[k] - at, below);
        }
        depth = fmaxf(depth, below * w.inverse[t]);
    }
    return __fdividef(depth, square_m);
}

/* Likewise a point. */
template <typename STAR>
__device__ inline float depth_of_place(const STAR &w, int count, const place<double> &p)
{
    const probe f = probe_of<3, false>(p);
    const float lift = fmaf(-1.25f, f.load, f.lift), size = -1.25f * f.size;
    float depth = 0.0f;
#pragma unroll 2
    for (int t = 0; t < count; t++) {
        const float4 q = w.s.sphere[t];
        const float least = fmaf(-q.x, f.x[0], fmaf(-q.y, f.x[1], fmaf(-q.z, f.x[2], fmaf(q.w, size, lift))));
        depth = fmaxf(depth, -least * w.inverse[t]);
    }
    return __fdividef(depth, fmaxf(f.lift, 1e-30f));
}

template <typename STAR> __device__ inline void find_inverses(STAR &w, int count)
{
    for (int t = (int)threadIdx.x & 31; t < count; t += 32) {
        const float size = w.s.sphere[t].w;
        w.inverse[t] = size < 0.0f || (w.s.triangle[t] & verified) != 0 ? 0.0f : size < 1e35f ? 1.0f / size : 1.0f;
    }
    __syncwarp();
}

/* Returns the lanes with candidates that are not yet vertices: the search meets vertices too. */
template <typename RUNG>
__device__ inline unsigned without_vertices(const wide_star<RUNG> &w, unsigned lanes, uint32_t candidate)
{
    for (unsigned rest = lanes; rest != 0; rest &= rest - 1) {
        const int from = __ffs((int)rest) - 1;
        const uint32_t id = __shfl_sync(all_lanes, candidate, from);
        bool known = false;
        for (int k = (int)threadIdx.x & 31; k < RUNG::vertices; k += 32) {
            known = known || w.s.id[k] == id;
        }
        lanes &= any(known) ? ~(1u << from) : ~0u;
    }
    return lanes;
}

/* The deepest of the bricks that wait, one for each 8 lanes, as depth << 16 | where it waits, or 0.  Where there is
   little room they are the last, which leave few more. */
template <typename RUNG> __device__ inline uint32_t deepest(const wide_star<RUNG> &w, int waits)
{
    const int lane = (int)threadIdx.x & 31;
    uint32_t best = 0;
    if (waits > RUNG::room - 32 * (brick_levels + 1)) {
        return 1u << 16 | (uint32_t)(waits - 1 - lane / 8);
    }
    for (int i = (lane & 7) * 4 + lane / 8; i < waits; i += 32) {
        const uint32_t key = (uint32_t)w.depth[i] << 16 | (uint32_t)i;
        best = key > best ? key : best;
    }
    return tile_max<8>(best);
}

/* A launch of a rung for surfaces: the vertices of a list, or if it is NULL total from first on, each stride-th.
   next: the first that no warp has taken; work, unless NULL: the sum of all looks. */
struct wide_launch {
    space all;
    brick_tree bricks;
    const unsigned long long *seed;
    const uint32_t *vertex;
    uint32_t first, stride, total, limit;
    uint32_t *next;
    unsigned long long *work;
    int cap;
    void *scratch;
    pbw__digit *pool;
    store in, out;
    queue failed, large;
};

/* A warp a star, from that of an earlier rung on.  The tree is searched once: a point or brick that no simplex of the
   star is in conflict with will never be, because stars only shrink; so when nothing waits any more the star is
   certified.  The deepest brick is searched first, the deepest point inserted first. */
template <typename RUNG>
__global__ void __launch_bounds__(32 * RUNG::warps, RUNG::blocks) wide_kernel(const __grid_constant__ wide_launch a)
{
    const space &all = a.all;
    const brick_tree &bricks = a.bricks;
    const int lane = (int)threadIdx.x;
    const unsigned below = lanes_below<32>();
    extern __shared__ float4 shared_words[];
    wide_star<RUNG> &w = RUNG::shared ? *(wide_star<RUNG> *)shared_words : ((wide_star<RUNG> *)a.scratch)[blockIdx.x];
    typename wide_star<RUNG>::type &s = w.s;
    uint32_t *waiting = s.scratch, *group = s.scratch + RUNG::room;
    pbw__digit *digits = a.pool == NULL ? NULL : a.pool + (blockIdx.x * 32 + (uint32_t)lane) * (size_t)PBW__POOL;
    for (;;) {
        uint32_t i = lane == 0 ? atomicAdd(a.next, 1u) : 0;
        i = __shfl_sync(all_lanes, i, 0);
        if (any(i >= a.total || *(volatile uint32_t *)a.failed.count > a.limit || *a.out.stop != 0)) {
            return;
        }
        const uint32_t v = a.vertex == NULL ? a.first + i * a.stride : a.vertex[i];
        const record own = all.point[v];
        const double origin[3] = { in_units(all, own, 0), in_units(all, own, 1), in_units(all, own, 2) };
        const unsigned walls = walls_of<3>(all, own);
        uint32_t candidate = none;
        place<double> p = relative<3, double>(all, own, own);
        int count = 0, waits = 4, groups = 0, spent = 0;
        bool started = a.in.place[v - a.in.first] != none, lost;
        unsigned pending = 0;
        float deep = 0.0f;                           /* the lane's candidate */
        for (int k = lane; k < RUNG::vertices; k += 32) {
            s.id[k] = none;
        }
        __syncwarp();
        if (started) {
            start_from_store<32>(s, true, all, a.in, v, own, walls, count);
        } else {
            started = start_on_curve<true>(s, all, a.seed, v, own, walls, digits, candidate, p, count);
            pending = started ? __ballot_sync(all_lanes, candidate != none) : 0;
        }
        lost = !started;
        if (lane < 4) {
            waiting[lane] = (uint32_t)bricks.levels << 28 | (uint32_t)lane;
            w.depth[lane] = 0x7f00;
        }
        find_inverses(w, count);
        if (pending != 0) {
            deep = depth_of_place(w, count, p);
            pending = without_vertices(w, __ballot_sync(all_lanes, deep > 0.0f) & pending, candidate);
        }
        while (!lost && (pending != 0 || waits > 0 || groups > 0)) {
            spent++;
            if (pending == 0 && (groups >= 4 || waits == 0)) {  /* the points of 4 groups */
                const int take = groups < 4 ? groups : 4;
                candidate = lane / 8 < take ? group[groups - 1 - lane / 8] * 8 + (uint32_t)(lane & 7) : none;
                candidate = candidate < all.count && candidate != v ? candidate : none;
                groups -= take;
                __syncwarp();
                p = relative<3, double>(all, own, all.point[candidate != none ? candidate : v]);
                deep = candidate != none ? depth_of_place(w, count, p) : 0.0f;
                pending = without_vertices(w, __ballot_sync(all_lanes, deep > 0.0f), candidate);
            } else if (pending == 0) {               /* the bricks in 4 bricks */
                const uint32_t best = deepest(w, waits);
                int at = best != 0 ? (int)(best & 0xffff) : -1;
                const uint32_t node = at >= 0 ? waiting[at] : 0;
                const uint32_t level = (node >> 28) - 1, index = (node & 0xfffffff) * 8 + (uint32_t)(lane & 7);
                float may = 0.0f;
                if (at >= 0 && index < bricks.size[level]) {
                    may = depth_of_brick(w, count, bricks.level[level][index], origin);
                }
                __syncwarp();
                for (int k = 0; k < 4; k++) {        /* the last takes its place */
                    const int most = warp_max<8>(at);
                    waits -= most >= 0;
                    if (most >= 0 && lane == 0) {
                        waiting[most] = waiting[waits];
                        w.depth[most] = w.depth[waits];
                    }
                    at = at == most ? -1 : at;
                    __syncwarp();
                }
                const unsigned deeper = __ballot_sync(all_lanes, may > 0.0f && level > 0);
                const unsigned found = __ballot_sync(all_lanes, may > 0.0f && level == 0);
                if (may > 0.0f && level > 0) {
                    const int to = waits + __popc(deeper & below);
                    waiting[to] = level << 28 | index;
                    w.depth[to] = (uint16_t)(__float_as_uint(fmaxf(may, 1e-30f)) >> 16);
                } else if (may > 0.0f) {
                    group[groups + __popc(found & below)] = index;
                }
                waits += __popc(deeper);
                groups += __popc(found);
                __syncwarp();
            } else {                                 /* the deepest point */
                const float most = -tile_min<32>((pending >> lane & 1) != 0 ? -deep : 1.0f);
                const int from = __ffs((int)(__ballot_sync(all_lanes, deep == most) & pending)) - 1;
                const uint32_t id = __shfl_sync(all_lanes, candidate, from);
                const int result = insert(s, all, v, id, tile_place<32>(p, from), count, walls, digits);
                pending &= ~(1u << from);
                lost = (result & ~star_changed) != 0;
                if (result == star_changed) {
                    find_inverses(w, count);
                }
                if (result == star_changed && pending != 0) {
                    deep = depth_of_place(w, count, p);
                    pending &= __ballot_sync(all_lanes, deep > 0.0f);
                }
            }
            lost = lost || spent > a.cap || ((spent & 63) == 0 && any(*a.out.stop != 0));
        }
        if (a.work != NULL && lane == 0) {
            atomicAdd(a.work, (unsigned long long)spent);
        }
        finish<32>(s, started, v, count, a.out);
        enqueue(a.failed, lane == 0 && lost, v);
        enqueue(a.large, lane == 0 && !lost && count > small_triangles - 4, v);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>cells        Simplices, neighbours, incident simplices, from the stars.
   A simplex is written by its lowest vertex, in the canonical form and order of >>output of pbw.h: the simplices of a
   vertex lie together, sorted by their second and third corner.  The two sides of a facet are seen in the star of the
   facet's lowest vertex, as two triangles with a common edge; their numbers are found among the simplices of their
   lowest vertices.
   On several cards the simplices of a share are one run of the result.  The stars of a share have simplices of lower
   shares too, those with a vertex in both: its guests, which the lower cards list for it with their numbers, in the
   canonical order.  The only facet of a guest whose lowest vertex may be of the share is the one that lacks the
   guest's first corner; what lies across it is what the lower cards hear in return.
   ------------------------------------------------------------------------------------------------------ */
template <int DIM> struct cell {
    uint32_t corner[DIM + 1];
};
template <> struct alignas(16) cell<3> {
    uint32_t corner[4];
};

/* The canonical form of the positive simplex (v, a...): the lowest corner first; in space the lowest of the rest
   second, in the plane the others in cyclic order. */
template <int DIM> __device__ inline cell<DIM> canonical(uint32_t v, const uint32_t *a)
{
    cell<DIM> c;
    uint32_t *p = c.corner;
    p[0] = v;
    for (int k = 0; k < DIM; k++) {
        p[k + 1] = a[k];
    }
    if (DIM == 3 && min(p[1], p[DIM]) < min(p[0], p[2])) {     /* pairs of exchanges keep it positive */
        exchange(p[0], p[1]);
        exchange(p[2], p[DIM]);
    }
    if (DIM == 3 && p[2] < p[0]) {
        exchange(p[0], p[2]);
        exchange(p[1], p[DIM]);
    }
    p += DIM - 2;
    for (int turns = 0; turns < 2; turns++) {
        if (p[1] < p[0] || p[2] < p[0]) {
            exchange(p[0], p[1]);
            exchange(p[1], p[2]);
        }
    }
    return c;
}

struct stored_star {
    const uint32_t *vertex, *triangle;
    int count, vertices;
};

__device__ inline stored_star stored(const store &in, uint32_t v)
{
    stored_star s = { NULL, NULL, 0, 0 };
    uint32_t at = in.place[v - in.first];
    if (at != hidden) {
        const uint32_t *word = in.word + (size_t)at * 4;
        s.count = (int)(word[0] >> 16);
        s.vertices = (int)(word[0] & 0xffff);
        s.vertex = word + 1;
        s.triangle = word + 1 + s.vertices;
    }
    return s;
}

/* The vertices of a triangle; returns whether all are finite. */
template <int DIM> __device__ inline bool triangle_of(const stored_star &s, int t, uint32_t *a)
{
    bool finite = true;
    for (int k = 0; k < DIM; k++) {
        a[k] = s.vertex[corner(s.triangle[t], k)];
        finite = finite && a[k] != none;
    }
    return finite;
}

/* Whether v comes before all vertices of a triangle, or all but the one at k. */
template <int DIM> __device__ inline bool is_lowest(uint32_t v, const uint32_t *a, int k = -1)
{
    bool lowest = true;
    for (int i = 0; i < DIM; i++) {
        lowest = lowest && (i == k || a[i] > v);
    }
    return lowest;
}

template <int DIM> __device__ inline uint64_t middle_corners(const cell<DIM> &c)
{
    return (uint64_t)c.corner[1] << 32 | c.corner[2];
}

/* The corners by other numbers. */
template <int DIM> __device__ inline cell<DIM> renumbered(cell<DIM> c, const uint32_t *number)
{
    for (int k = 0; k <= DIM; k++) {
        c.corner[k] = number[c.corner[k]];
    }
    return c;
}

const int emit_block = 64, emit_keys = 64;

/* The simplices of a share, in order, by ranks; where those of each vertex begin; the guests. */
template <int DIM> struct directory {
    uint32_t first, base, guests;                    /* first vertex, number of the first simplex */
    const uint32_t *offset, *guest_number;
    const cell<DIM> *cells, *guest;
};

/* 8 lanes a star.  cells: simplices by ranks; out: by the caller's ids.  Where there is no room for the keys of the
   simplices, each is compared with those of the star. */
template <int DIM>
__global__ void emit_kernel(const __grid_constant__ store in, const uint32_t *offset, const uint32_t *id,
                            cell<DIM> *cells, cell<DIM> *out)
{
    const int T = 8;
    __shared__ uint64_t shared_keys[emit_block / T][emit_keys];
    uint64_t *keys = shared_keys[threadIdx.x / T];
    int lane = (int)threadIdx.x & (T - 1), found = 0;
    uint32_t v = in.first + (blockIdx.x * emit_block + threadIdx.x) / T;
    bool go = v < in.end;
    uint32_t owned = go ? in.owned[v - in.first] : 0, first = go ? offset[v - in.first] : 0;
    stored_star s = { NULL, NULL, 0, 0 };
    if (owned > 0) {
        s = stored(in, v);
    }
    const bool fits = owned <= emit_keys;
    auto own_cell = [&](int t, cell<DIM> &c) {
        uint32_t a[3];
        const bool mine = t < s.count && triangle_of<DIM>(s, t, a) && is_lowest<DIM>(v, a);
        c = mine ? canonical<DIM>(v, a) : cell<DIM>();
        return mine;
    };
    for (int base = 0; any(fits && base < s.count); base += T) {
        cell<DIM> c;
        const bool mine = fits && own_cell(base + lane, c);
        const unsigned vote = tile_ballot<T>(mine);
        if (mine) {
            keys[found + __popc(vote & lanes_below<T>())] = middle_corners(c);
        }
        found += __popc(vote);
    }
    __syncwarp();
    for (int t = lane; t < s.count; t += T) {
        cell<DIM> c, other;
        const bool mine = own_cell(t, c);
        uint32_t before = 0;
        for (int i = 0; mine && i < (fits ? found : s.count); i++) {
            before += (fits ? keys[i] : own_cell(i, other) ? middle_corners(other) : ~0ull) < middle_corners(c);
        }
        if (mine) {
            cells[first + before] = c;
            out[first + before] = renumbered(c, id);
        }
    }
}

/* The last of the cells from low to high that does not come after c, by all but the last corner. */
template <int DIM>
__device__ inline uint32_t last_until(const cell<DIM> &c, const cell<DIM> *cells, uint32_t low, uint32_t high)
{
    while (low + 1 < high) {
        uint32_t middle = (low + high) / 2;
        cell<DIM> other = cells[middle];
        bool below = other.corner[0] < c.corner[0]
                  || (other.corner[0] == c.corner[0] && middle_corners(other) <= middle_corners(c));
        low = below ? middle : low;
        high = below ? high : middle;
    }
    return low;
}

/* The number of a simplex, by its canonical form. */
template <int DIM> __device__ inline uint32_t number_of(const cell<DIM> &c, const directory<DIM> &all)
{
    if (c.corner[0] < all.first) {
        return all.guest_number[last_until<DIM>(c, all.guest, 0, all.guests)];
    }
    const uint32_t *offset = all.offset + (c.corner[0] - all.first);
    return all.base + last_until<DIM>(c, all.cells, offset[0], offset[1]);
}

/* Where links go.  neighbors: NULL if nobody wants them; beyond: for each guest what lies across its facet; incident:
   by the caller's ids, or from the share's first vertex on if id is NULL. */
struct links {
    pbw_index *neighbors, *beyond, *incident;
    const uint32_t *id;
};

/* The links of the simplex (v, a...), finite and of number own, across the facets of which v is the lowest vertex;
   across(k): the number of the simplex beyond the facet that lacks a[k]. */
template <int DIM, typename F>
__device__ inline void link_simplex(const directory<DIM> &all, const links &out, uint32_t v, const uint32_t *a,
                                    uint32_t own, F across)
{
    const cell<DIM> c = canonical<DIM>(v, a);
    for (int k = 0; k < DIM; k++) {
        if (is_lowest<DIM>(v, a, k) && c.corner[0] < all.first) {
            out.beyond[last_until<DIM>(c, all.guest, 0, all.guests)] = across(k);
        } else if (is_lowest<DIM>(v, a, k)) {
            int at = 0;
            for (int i = 1; i <= DIM; i++) {
                at = c.corner[i] == a[k] ? i : at;
            }
            out.neighbors[(size_t)(own - all.base) * (DIM + 1) + (size_t)at] = across(k);
        }
    }
}

/* The links of the small stars, 8 lanes each, with tables of mates: 3D: of the triangle that has a directed edge; 2D:
   row 0: of the edge that begins at a vertex; row 1: that ends there. */
template <int DIM>
__global__ void neighbor_kernel(const __grid_constant__ store in, const __grid_constant__ directory<DIM> all,
                                const __grid_constant__ links out, uint32_t *hidden_count)
{
    const int T = 8;
    __shared__ uint8_t shared_table[emit_block / T][small_vertices * small_vertices];
    __shared__ uint32_t shared_number[emit_block / T][small_triangles + 4];
    uint8_t *table = shared_table[threadIdx.x / T];
    uint32_t *number = shared_number[threadIdx.x / T];
    int lane = (int)threadIdx.x & (T - 1);
    uint32_t v = in.first + (blockIdx.x * emit_block + threadIdx.x) / T, lowest = none, a[3];
    stored_star s = { NULL, NULL, 0, 0 };
    bool go = v < in.end;
    if (go) {
        s = stored(in, v);
    }
    bool is_hidden = go && s.count == 0;
    go = s.count > 0 && s.count <= small_triangles && s.vertices <= small_vertices;
    for (int t = lane; go && t < s.count; t += T) {
        for (int k = 0; k < DIM; k++) {
            uint32_t from = corner(s.triangle[t], k), to = corner(s.triangle[t], k + 1 == DIM ? 0 : k + 1);
            table[DIM == 3 ? from * small_vertices + to : (uint32_t)k * small_vertices + from] = (uint8_t)t;
        }
        number[t] = triangle_of<DIM>(s, t, a) ? number_of<DIM>(canonical<DIM>(v, a), all) : none;
        lowest = min(lowest, number[t]);
    }
    __syncwarp();
    lowest = tile_min<T>(lowest);
    for (int t = lane; go && out.neighbors != NULL && t < s.count; t += T) {
        if (triangle_of<DIM>(s, t, a)) {
            link_simplex<DIM>(all, out, v, a, number[t], [&](int k) {
                uint32_t c[3] = { corner(s.triangle[t], 0), corner(s.triangle[t], 1), corner(s.triangle[t], 2) };
                uint32_t from = DIM == 3 ? c[(k + 2) % 3] : (uint32_t)k, to = DIM == 3 ? c[(k + 1) % 3] : c[1 - k];
                return number[table[from * small_vertices + to]];
            });
        }
    }
    if (go && lane == 0) {
        out.incident[out.id != NULL ? out.id[v] : v - in.first] = lowest;
    }
    if (is_hidden && lane == 0) {
        atomicAdd(hidden_count, 1u);
    }
}

/* The same for larger stars, a warp each, looking for mates one by one. */
template <int DIM>
__global__ void large_neighbor_kernel(queue large, const __grid_constant__ store in,
                                      const __grid_constant__ directory<DIM> all, const __grid_constant__ links out)
{
    uint32_t i = blockIdx.x * (blockDim.x / 32) + threadIdx.x / 32, lowest = none;
    if (i >= *large.count) {
        return;
    }
    uint32_t v = large.vertex[i];
    stored_star s = stored(in, v);
    if (s.count <= small_triangles && s.vertices <= small_vertices) {
        return;
    }
    auto number = [&](int t, uint32_t *a) {
        return t >= 0 && triangle_of<DIM>(s, t, a) ? number_of<DIM>(canonical<DIM>(v, a), all) : none;
    };
    for (int t = (int)threadIdx.x & 31; t < s.count; t += 32) {
        uint32_t a[3], b[3], own = number(t, a);
        lowest = min(lowest, own);
        if (own != none && out.neighbors != NULL) {
            link_simplex<DIM>(all, out, v, a, own, [&](int k) {
                return number(mate_of<DIM>(s.triangle, s.count, s.triangle[t], k), b);
            });
        }
    }
    lowest = tile_min<32>(lowest);
    if ((threadIdx.x & 31) == 0) {
        out.incident[out.id != NULL ? out.id[v] : v - in.first] = lowest;
    }
}

/* A run of vertices. */
struct share {
    uint32_t first, end;
    __device__ bool has(uint32_t v) const { return v >= first && v < end; }
};

/* The guests that one card has for another: counted, and where those of each vertex go. */
template <int DIM> struct guest_list {
    uint32_t *count;
    const uint32_t *place;
    cell<DIM> *guest;                                /* NULL: they are only counted */
    uint32_t *number;
};

/* Lists the simplices of a share that have vertices of another, a thread a vertex. */
template <int DIM>
__global__ void guest_kernel(const __grid_constant__ directory<DIM> all, uint32_t vertices, share other,
                             const __grid_constant__ guest_list<DIM> out)
{
    size_t v = thread_number();
    uint32_t found = 0;
    for (uint32_t i = v < vertices ? all.offset[v] : 0; v < vertices && i < all.offset[v + 1]; i++) {
        cell<DIM> c = all.cells[i];
        bool visits = false;
        for (int k = 1; k <= DIM; k++) {
            visits = visits || other.has(c.corner[k]);
        }
        if (visits && out.guest != NULL) {
            out.guest[out.place[v] + found] = c;
            out.number[out.place[v] + found] = all.base + i;
        }
        found += visits;
    }
    if (v < vertices && out.guest == NULL) {
        out.count[v] = found;
    }
}

/* What the vertices of another share know of their guests. */
template <int DIM>
__global__ void return_kernel(const __grid_constant__ directory<DIM> all, share other, uint32_t count,
                              const uint32_t *number, const pbw_index *beyond, pbw_index *neighbors)
{
    size_t i = thread_number();
    if (i < count) {
        uint32_t own = number[i] - all.base, second = none;
        cell<DIM> c = all.cells[own];
        for (int k = 1; k <= DIM; k++) {
            second = min(second, c.corner[k]);
        }
        if (other.has(second)) {
            neighbors[(size_t)own * (DIM + 1)] = beyond[i];
        }
    }
}

/* out[id[i]] = value[i], or i without values. */
__global__ void scatter_kernel(const uint32_t *id, uint32_t count, const uint32_t *value, uint32_t *out)
{
    size_t i = thread_number();
    if (i < count) {
        out[id[i]] = value != NULL ? value[i] : (uint32_t)i;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>check        The exact verdict on a mesh.
   In: points and the arrays of a mesh.  Out: the first fault of the first pass that has one, and counts.  The tests
   are those of pbw_check, in its order (>>faults of pbw.h); but that two hidden points lie at one place is not found.
   The passes: points, simplices, hull, hidden points; a thread an item.  An item that the stages without memory leave
   open is listed, and tested again by a thread that has a pool.
   ------------------------------------------------------------------------------------------------------ */
enum { check_points, check_simplices, check_hull, check_hidden, check_passes };

struct view : pbw__tested {
    const uint32_t *order;                           /* points along the curve, or NULL */
};

struct check_result {
    unsigned long long least;                        /* item of the first fault << 32 | fault */
    unsigned long long counted[check_passes][3];
    uint32_t open;                                   /* items listed */
    pbw__finding first;
};

__global__ void record_kernel(input in, double *record)
{
    size_t i = thread_number();
    if (i < in.count) {
        fetch(in, i, record + i * (size_t)(in.dim + 1));
    }
}

/* The ridges of the hull facets of a simplex. */
template <int DIM> __device__ int test_ridges(const view &m, uint32_t s, pbw__finding *found)
{
    for (int i = 0; i <= DIM; i++) {
        for (int k = 0; k <= DIM && m.neighbors[(size_t)s * (DIM + 1) + (size_t)i] == none; k++) {
            pbw__turn turn = { s, i, k };
            while (k != i && pbw__turn_on(&m, DIM, &turn)) {
            }
            if (k != i && !pbw__test_ridge(&m, DIM, s, i, &turn, found)) {
                return 0;
            }
        }
    }
    return 1;
}

/* A simplex near the point of a rank: one of a vertex before it on the curve. */
__device__ inline uint32_t simplex_near(const view &m, uint32_t rank)
{
    uint32_t found = none;
    for (int tries = 0; tries < 64 && rank > 0 && found == none; tries++) {
        found = m.incident[m.order[--rank]];
    }
    return found != none ? found : 0;
}

/* A point, if it is neither a vertex nor a duplicate; with an order, the item is a rank. */
template <int DIM> __device__ int test_hidden(const view &m, uint32_t item, pbw__finding *found)
{
    const uint32_t point = m.order != NULL ? m.order[item] : item;
    if (m.canonical[point] != point || m.incident[point] != none) {
        return 1;
    }
    const uint32_t start = m.order != NULL ? simplex_near(m, item) : 0;
    pbw__visit visit = { point, start, start };
    while (pbw__visit_on(&m, DIM, &visit, found)) {
    }
    return pbw__test_visited(&m, DIM, &visit, found);
}

const unsigned check_blocks = 64;                    /* of 32 threads that have pools */

/* Items 0, ..., count - 1, or those of a list, one thread each or in turn, up to the first known fault; a single one
   is described. */
template <int DIM>
__global__ void check_kernel(const __grid_constant__ view m, int pass, uint32_t count, const uint32_t *list,
                             uint32_t *open, pbw__digit *pool, check_result *out)
{
    const size_t thread = thread_number(), threads = (size_t)gridDim.x * blockDim.x;
    pbw__digit *const own_pool = pool != NULL ? pool + thread * PBW__POOL : NULL;
    unsigned long long counted[3] = { 0, 0, 0 };     /* by sound items: an open one comes again */
    for (size_t i = thread; i < count; i += threads) {
        pbw__finding found = { own_pool, PBW__SOUND, -1, none, none, { 0, 0, 0 } };
        uint32_t item = list == NULL ? (uint32_t)i : list[i];
        if (count > 1 && *(const volatile unsigned long long *)&out->least >> 32 < item) {
            continue;
        }
        int sound = pass == check_points ? pbw__test_point(&m, DIM, item, &found)
                  : pass == check_simplices ? pbw__test_simplex(&m, DIM, item, &found)
                  : pass == check_hull ? test_ridges<DIM>(m, item, &found) : test_hidden<DIM>(m, item, &found);
        if (!sound && found.fault == PBW__FAULT_OPEN) {
            open[atomicAdd(&out->open, 1u)] = item;
        } else if (!sound) {
            atomicMin(&out->least, (unsigned long long)item << 32 | (unsigned)found.fault);
            if (count == 1) {
                out->first = found;
            }
        }
        for (int k = 0; k < 3; k++) {
            counted[k] += sound ? found.counted[k] : 0;
        }
    }
    __syncwarp();
    for (int k = 0; k < 3; k++) {
        counted[k] = tile_sum<32>(counted[k]);
        if ((threadIdx.x & 31) == 0 && counted[k] > 0) {
            atomicAdd(&out->counted[pass][k], counted[k]);
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>keep         A mesh whose points have moved, put into the order of the curve again.
   In: a mesh that holds for its points where they are now, by the ids of the caller; the new order of the points.
   Out: its arrays as >>cells writes them: simplices in canonical form, sorted by their first three corners.
   ------------------------------------------------------------------------------------------------------ */
__global__ void compare_kernel(const uint32_t *a, const uint32_t *b, uint32_t count, uint32_t *differ)
{
    size_t i = thread_number();
    if (any(i < count && a[i] != b[i]) && (threadIdx.x & 31) == 0) {
        *differ = 1;
    }
}

/* A mesh on its way into a new order. */
struct reorder {
    const pbw_index *simplices, *neighbors;          /* in the old order */
    const uint32_t *id, *rank;                       /* of each rank; of each id */
    uint32_t count;                                  /* simplices */
    int bits;                                        /* of a rank */
};

/* The canonical form of a simplex, by ranks. */
template <int DIM> __device__ inline cell<DIM> ranked(const reorder &m, uint32_t s)
{
    const cell<DIM> c = renumbered(((const cell<DIM> *)m.simplices)[s], m.rank);
    return canonical<DIM>(c.corner[0], c.corner + 1);
}

template <int DIM> __global__ void third_kernel(const __grid_constant__ reorder m, uint32_t *key, uint32_t *simplex)
{
    size_t i = thread_number();
    if (i < m.count) {
        key[i] = ranked<DIM>(m, (uint32_t)i).corner[2];
        simplex[i] = (uint32_t)i;
    }
}

template <int DIM>
__global__ void first_kernel(const __grid_constant__ reorder m, const uint32_t *simplex, uint64_t *key)
{
    size_t i = thread_number();
    if (i < m.count) {
        cell<DIM> c = ranked<DIM>(m, simplex[i]);
        key[i] = (uint64_t)c.corner[0] << m.bits | c.corner[1];
    }
}

/* order: the old number of each new one; now: the new number of each old one. */
template <int DIM>
__global__ void rewrite_kernel(const __grid_constant__ reorder m, const uint32_t *order, const uint32_t *now,
                               pbw_index *simplices, pbw_index *neighbors, pbw_index *incident)
{
    size_t i = thread_number();
    if (i >= m.count) {
        return;
    }
    uint32_t s = order[i];
    cell<DIM> old = ((const cell<DIM> *)m.simplices)[s], across = ((const cell<DIM> *)m.neighbors)[s];
    cell<DIM> c = ranked<DIM>(m, s), other;
    for (int k = 0; k <= DIM; k++) {
        uint32_t v = m.id[c.corner[k]], t = none;
        for (int j = 0; j <= DIM; j++) {
            t = old.corner[j] == v ? across.corner[j] : t;
        }
        c.corner[k] = v;
        other.corner[k] = t == none ? none : now[t];
        if (incident[v] > i) {
            atomicMin(&incident[v], (uint32_t)i);
        }
    }
    ((cell<DIM> *)simplices)[i] = c;
    ((cell<DIM> *)neighbors)[i] = other;
}

/* ------------------------------------------------------------------------------------------------------
   >>run          The stages in order.
   In: packed points on the device.  Out: the arrays on the device, and for a job of pbw.h also in its memory, copied
   while later stages run.  Everything is in the order of one stream; the host waits where it needs a count.
   A team of cards works on one job, each with a thread of the host and a share of the curve: all put all points into
   order and grow the whole tree, each makes the stars of its share and writes its run of the simplices.  The cards
   meet to number the simplices, to fetch their guests, and to hear what lies across them.  What one offers to others
   is complete when they meet, and stays until all leave.
   A stage that fails sets the status of its call, says why, and throws; so the next one may count on all before it.
   The entries catch, and free what the call has.
   ------------------------------------------------------------------------------------------------------ */
/* Of device memory at the peak, uniform points, in 2D and 3D: for all points, and more for those of the share. */
const double bytes_a_point[2] = { 75.0, 90.0 }, bytes_a_star[2] = { 155.0, 560.0 };
const int most_cards = 16;
const char *const few_points = "so few points are quicker on the CPU";
const char *const no_host_memory = "out of memory on the host";
const char *const too_many = "too many simplices for the index type";

struct offer {                                       /* what a card has for the others */
    int device;
    share part;
    uint32_t simplices;
    void *guests[most_cards];                        /* for each higher card */
    uint32_t *guest_numbers[most_cards], guest_count[most_cards];
    pbw_index *beyond, *incident;                    /* beyond: of all guests, those of the lowest card first */
    bool open[most_cards];                           /* whether a card can read from this one */
};

struct team {
    std::mutex lock;
    std::condition_variable news;
    int cards, here = 0, left = 0;
    unsigned meetings = 0;
    std::atomic<int> status{ PBW_OK };               /* of the first card that failed */
    bool declined = false;
    offer of[most_cards] = {};
};

/* What a call uses besides its blocks; that of a loop serves all its steps. */
struct gear {
    cudaMemPool_t pool;
    cudaStream_t copies;
    cudaEvent_t mark[8], ready, copied;
    char *pinned;                                    /* host memory for counts; NULL but in a loop */
};
const size_t pinned_bytes = 512;

/* What a loop passes on from step to step. */
struct keepsake {
    pbw_cuda_mesh mesh;
    uint32_t *id, count;                             /* of each rank; NULL if the CPU built the mesh */
};

struct call : gear {
    team *cards;                                     /* NULL: alone */
    keepsake *last;                                  /* NULL: no step of a loop */
    bool lent, anew;                                 /* lent: the gear; anew: the last mesh is not looked at */
    int card;
    cudaStream_t stream;
    pbw_job *job;                                    /* without reserve, keep: results stay on the device */
    size_t used, count, stars;                       /* bytes; stars: of the share */
    uint32_t *stop;                                  /* on the device: kernels of stars end early if it is not 0 */
    bool stopped;
    int dim;
    pbw_status status;
    bool declined, must;                             /* must: there is no CPU that it could be left to */
    struct { void *address; size_t bytes; } block[40 + 3 * most_cards];
    int blocks;
};

/* Reports the first failure of any card; then all stop. */
void fall_out(call &c, const char *text)
{
    std::lock_guard<std::mutex> hold(c.cards->lock);
    if (c.cards->status == PBW_OK && c.status != PBW_OK) {
        c.cards->status = c.status;
        c.cards->declined = c.declined;
        if (text != NULL) {
            c.job->say(c.job, text);
        }
        c.cards->news.notify_all();
    }
}

void say(call &c, const char *format, ...)
{
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (c.cards != NULL) {
        fall_out(c, text);
    } else {
        c.job->say(c.job, text);
    }
}

struct failure {};                                   /* thrown: the status of the call is no longer PBW_OK */

void go_on(const call &c)
{
    if (c.status != PBW_OK) {
        throw failure();
    }
}

/* Fails unless a condition holds. */
template <typename... A> void require(call &c, bool holds, pbw_status status, const char *format, A... arguments)
{
    if (!holds && c.status == PBW_OK) {
        c.status = status;
        say(c, format, arguments...);
    }
    if (!holds) {
        throw failure();
    }
}

/* The same for what only the device lacks: the CPU may take over. */
template <typename... A> void suit(call &c, bool suits, const char *format, A... arguments)
{
    c.declined = c.declined || !suits;
    require(c, suits, PBW_ERROR_BACKEND, format, arguments...);
}

/* A rung left some stars. */
void suit_stars(call &c, uint32_t left, uint32_t limit)
{
    suit(c, left <= limit, "%u stars are too large for the device (cospherical points?)", left);
}

/* Takes over a failure of the device; returns whether the call has none. */
bool good(call &c, cudaError_t error, const char *what)
{
    if (error != cudaSuccess && c.status == PBW_OK) {
        c.status = PBW_ERROR_BACKEND;
        say(c, "%s: %s", what, cudaGetErrorString(error));
    }
    return c.status == PBW_OK;
}

void need(call &c, cudaError_t error, const char *what)
{
    good(c, error, what);
    go_on(c);
}

/* Fails unless more bytes fit into the device's free memory and its pool.  The message says what is needed in all,
   for this input as far as is known. */
void need_memory(call &c, size_t more)
{
    size_t available = 0, all = 0, needed = c.used + more;
    size_t usual = (size_t)((double)c.count * bytes_a_point[c.dim - 2] + (double)c.stars * bytes_a_star[c.dim - 2]);
    uint64_t kept = 0, used = 0;
    need(c, cudaMemGetInfo(&available, &all), "cudaMemGetInfo");
    need(c, cudaMemPoolGetAttribute(c.pool, cudaMemPoolAttrReservedMemCurrent, &kept), "memory of the pool");
    need(c, cudaMemPoolGetAttribute(c.pool, cudaMemPoolAttrUsedMemCurrent, &used), "memory of the pool");
    available += c.used + (kept > used ? (size_t)(kept - used) : 0);
    available = c.job->memory_limit > 0 && c.job->memory_limit < available ? c.job->memory_limit : available;
    require(c, needed <= available, PBW_ERROR_BACKEND,
            "too little device memory: %zu bytes are needed, %zu are available", usual > needed ? usual : needed,
            available);
}

void own(call &c, void *block, size_t bytes)
{
    c.block[c.blocks].address = block;
    c.block[c.blocks++].bytes = bytes;
    c.used += bytes;
}

template <typename V> V *allocate(call &c, size_t count)
{
    void *block = NULL;
    const size_t bytes = (count > 0 ? count : 1) * sizeof(V);
    require(c, c.blocks < (int)(sizeof c.block / sizeof c.block[0]), PBW_ERROR_BACKEND,
            "too many blocks of device memory");
    if (c.job->memory_limit > 0 && c.used + bytes > c.job->memory_limit) {
        need_memory(c, bytes);
    }
    const bool fails = pbw_cuda_fail_at > 0 && --pbw_cuda_fail_at == 0;
    cudaError_t error = fails ? cudaErrorMemoryAllocation
                              : cudaMallocFromPoolAsync(&block, bytes, c.pool, c.stream);
    if (error == cudaErrorMemoryAllocation) {
        (void)cudaGetLastError();
        need_memory(c, bytes);
    }
    need(c, error, "cudaMallocAsync");
    own(c, block, bytes);
    return (V *)block;
}

/* Frees a block, or with keep only drops it from the list. */
void release(call &c, const void *address, bool keep = false)
{
    for (int i = 0; i < c.blocks; i++) {
        if (address != NULL && c.block[i].address == address) {
            c.used -= c.block[i].bytes;
            if (!keep) {
                cudaFreeAsync(c.block[i].address, c.stream);
            }
            c.block[i] = c.block[--c.blocks];
            return;
        }
    }
}

/* Device memory that is freed at the end of its scope. */
template <typename V> struct buffer {
    call &c;
    V *at;
    explicit buffer(call &of) : c(of), at(NULL) {}
    buffer(call &of, size_t count) : c(of), at(NULL) { make(count); }
    buffer(buffer &&from) : c(from.c), at(from.at) { from.at = NULL; }
    buffer &operator=(buffer &&from) { std::swap(at, from.at); return *this; }
    ~buffer() { release(c, at); }
    void make(size_t count) { at = allocate<V>(c, count); }
};

/* Reports progress on the caller's thread, and takes over a cancellation or another card's failure. */
void look_up(call &c, pbw_stage stage, double done)
{
    if (c.card == 0 && c.status == PBW_OK && c.job->report(c.job, stage, done) != 0) {
        c.status = PBW_CANCELLED;
        if (c.cards != NULL) {
            fall_out(c, NULL);
        }
    }
    if (c.cards != NULL && c.status == PBW_OK && c.cards->status != PBW_OK) {
        c.status = (pbw_status)c.cards->status.load();
    }
}

/* Waits for a stream and reports progress meanwhile.  When the call is cancelled or another card has failed, sets the
   stop word of the kernels through the other stream. */
void finish_stream(call &c, cudaStream_t stream, pbw_stage stage, double done)
{
    static const uint32_t one = 1;
    cudaError_t error = cudaEventRecord(c.ready, stream);
    while (error == cudaSuccess && (error = cudaEventQuery(c.ready)) == cudaErrorNotReady) {
        look_up(c, stage, done);
        if (c.status != PBW_OK && c.stop != NULL && !c.stopped) {
            c.stopped = true;
            cudaMemcpyAsync(c.stop, &one, sizeof one, cudaMemcpyHostToDevice, c.copies);
        }
        std::this_thread::yield();
        error = cudaSuccess;
    }
    good(c, error, "waiting for the device");
}

void wait(call &c, pbw_stage stage, double done)
{
    finish_stream(c, c.stream, stage, done);
    go_on(c);
}

/* Waits for the other cards, or with leaving for all to have left, however they fared. */
void meet_cards(call &c, bool leaving, double done)
{
    team &t = *c.cards;
    std::unique_lock<std::mutex> hold(t.lock);
    unsigned meeting = t.meetings;
    t.left += leaving;
    t.here += !leaving;
    if (t.here == t.cards) {
        t.here = 0;
        t.meetings++;
    }
    t.news.notify_all();
    while (leaving ? t.left < t.cards : t.meetings == meeting && t.status == PBW_OK) {
        t.news.wait_for(hold, std::chrono::milliseconds(20));
        hold.unlock();
        look_up(c, PBW_STAGE_OUTPUT, done);
        hold.lock();
    }
    hold.unlock();
    look_up(c, PBW_STAGE_OUTPUT, done);
    if (!leaving) {
        go_on(c);
    }
}

template <typename V> V read_back(call &c, const V *address, pbw_stage stage, double done)
{
    static_assert(sizeof(V) <= pinned_bytes, "room for what is read back");
    V value, *to = c.pinned != NULL ? (V *)c.pinned : &value;
    if (c.pinned == NULL) {                          /* the copy would block */
        wait(c, stage, done);
    }
    need(c, cudaMemcpyAsync(to, address, sizeof(V), cudaMemcpyDeviceToHost, c.stream), "reading a count");
    if (c.pinned == NULL) {
        need(c, cudaStreamSynchronize(c.stream), "reading a count");
    } else {
        wait(c, stage, done);
    }
    return *to;
}

template <typename V> void fill(call &c, V *address, int byte, size_t count)
{
    need(c, cudaMemsetAsync(address, byte, count * sizeof(V), c.stream), "cudaMemsetAsync");
}

void note(call &c, int mark)
{
    need(c, cudaEventRecord(c.mark[mark], c.stream), "cudaEventRecord");
}

/* What is queued on the other stream from now on follows what is queued on the call's. */
void follow(call &c)
{
    need(c, cudaEventRecord(c.copied, c.stream), "cudaEventRecord");
    need(c, cudaStreamWaitEvent(c.copies, c.copied, 0), "cudaStreamWaitEvent");
}

struct shape {                                       /* of a launch; bytes: of dynamic shared memory */
    unsigned blocks, threads;
    size_t bytes;
};

shape over(size_t threads, unsigned block)
{
    return { threads > 0 ? (unsigned)((threads + block - 1) / block) : 1, block, 0 };
}

/* For loops that stride over the grid. */
shape at_most(unsigned blocks, shape s)
{
    s.blocks = s.blocks < blocks ? s.blocks : blocks;
    return s;
}

template <typename... P, typename... A>
void launch(call &c, const char *what, void (*kernel)(P...), shape s, const A &...arguments)
{
    kernel<<<s.blocks, s.threads, s.bytes, c.stream>>>(arguments...);
    need(c, cudaGetLastError(), what);
}

/* An array and room to sort it. */
template <typename V> struct sortable {
    buffer<V> array, spare;
    explicit sortable(call &c) : array(c), spare(c) {}
    sortable(call &c, size_t count) : array(c, count), spare(c, count) {}
    void take(cub::DoubleBuffer<V> &sorted)
    {
        array.at = sorted.Current();
        spare.at = sorted.Alternate();
    }
};

/* Calls a function of CUB, at first for the size of the scratch memory that it needs. */
template <typename F> void with_scratch(call &c, const char *what, F function)
{
    size_t bytes = 0;
    need(c, function((void *)NULL, bytes), what);
    buffer<char> scratch(c, bytes);
    need(c, function((void *)scratch.at, bytes), what);
}

/* Sorts by the bits of the keys from low to high - 1. */
struct key_bits {
    int low, high;
};

void sort_keys(call &c, sortable<uint64_t> &key, size_t count, key_bits by)
{
    cub::DoubleBuffer<uint64_t> keys(key.array.at, key.spare.at);
    with_scratch(c, "sort", [&](void *scratch, size_t &bytes) {
        return cub::DeviceRadixSort::SortKeys(scratch, bytes, keys, count, by.low, by.high, c.stream);
    });
    key.take(keys);
}

template <typename K, typename V>
void sort_pairs(call &c, sortable<K> &key, sortable<V> &value, size_t count, key_bits by)
{
    cub::DoubleBuffer<K> keys(key.array.at, key.spare.at);
    cub::DoubleBuffer<V> values(value.array.at, value.spare.at);
    with_scratch(c, "sort", [&](void *scratch, size_t &bytes) {
        return cub::DeviceRadixSort::SortPairs(scratch, bytes, keys, values, count, by.low, by.high, c.stream);
    });
    key.take(keys);
    value.take(values);
}

void sum_before(call &c, const uint32_t *value, uint32_t *sum, size_t count)
{
    with_scratch(c, "scan", [&](void *scratch, size_t &bytes) {
        return cub::DeviceScan::ExclusiveSum(scratch, bytes, value, sum, count, c.stream);
    });
}

struct run_room {
    buffer<uint32_t> head, end, length, offset;
    explicit run_room(call &c) : head(c), end(c), length(c), offset(c) {}
    run_room(call &c, size_t count) : head(c, count), end(c, count), length(c, count + 1), offset(c, count + 1) {}
    run_list list() const { return { head.at, end.at, length.at, offset.at }; }
};

/* Points on their way into the order of the curve. */
struct ordering {
    keyed all;
    sortable<uint64_t> key;
    buffer<uint32_t> root;                           /* empty if there are no long runs */
    buffer<survey> found;
    ordering(call &c, const input &in) : key(c), root(c), found(c, 1)
    {
        pbw__curve one_level;
        pbw__curve_create(&one_level, 0, in.dim);
        memcpy(all.step, one_level.step, sizeof all.step);
        all.in = in;
        all.index_bits = pbw__index_bits(in.count);
        all.bits = pbw__grid_bits(all.index_bits, in.dim);
    }
    key_bits sorted_bits() const { return { all.index_bits, all.index_bits + all.bits * all.in.dim }; }
};

/* The points of the long runs of a list get keys from grids of their own and are put back in their order.  Returns
   the long runs among those, count of them. */
run_room order_long_runs(call &c, ordering &o, const run_list &runs, uint32_t &count)
{
    const shape warps = over((size_t)count * 32, 128);
    const uint32_t runs_here = count;
    buffer<pbw__box> box(c, count);
    run_room next(c);
    fill(c, runs.length + count, 0, 1);
    launch(c, "runs", measure_kernel, warps, o.all, runs, count, box.at, o.root.at);
    sum_before(c, runs.length, runs.offset, (size_t)count + 1);
    const uint32_t total = read_back(c, runs.offset + count, PBW_STAGE_ORDER, 0.4);
    count = 0;
    if (total > 0) {
        sortable<uint64_t> gathered(c, total);
        sortable<uint32_t> segment(c, total);
        keyed some = o.all;
        launch(c, "runs", rekey_kernel, warps, o.all, runs, runs_here, box.at, gathered.array.at, segment.array.at);
        sort_pairs(c, gathered, segment, total, o.sorted_bits());
        sort_pairs(c, segment, gathered, total, { 0, pbw__index_bits(runs_here) });
        some.key = gathered.array.at;
        next = run_room(c, total / PBW__SHORT_RUN + 1);
        fill(c, &o.found.at->long_runs, 0, 1);
        launch(c, "runs", run_kernel, over(total, 256), some, total, segment.array.at, runs, next.list(), o.found.at);
        launch(c, "runs", put_back_kernel, over(total, 256), some.key, segment.array.at, total, runs, o.all.key);
        count = read_back(c, &o.found.at->long_runs, PBW_STAGE_ORDER, 0.4);
    }
    return next;
}

/* Puts the runs of equal keys into order.  The depth is bounded as in >>order of pbw.h: each level divides the extent
   by 2^bits. */
void order_runs(call &c, ordering &o)
{
    const size_t n = o.all.in.count;
    run_room runs(c, n / PBW__SHORT_RUN + 1);
    launch(c, "runs", run_kernel, over(n, 256), o.all, n, nullptr, run_list(), runs.list(), o.found.at);
    uint32_t count = read_back(c, &o.found.at->long_runs, PBW_STAGE_ORDER, 0.4);
    if (count > 0) {
        o.root.make(n);
        fill(c, o.root.at, 0xff, n);
    }
    while (count > 0) {
        runs = order_long_runs(c, o, runs.list(), count);
    }
}

/* The ranges of coordinates and weights, and what all are multiples of.  on_device: the same, for later kernels. */
pbw__grid_share survey_points(call &c, const input &in, const buffer<survey> &on_device)
{
    survey found = {};
    pbw__grid_share range;
    memset(found.low, 0xff, sizeof found.low);
    found.unit = 1024;
    need(c, cudaMemcpyAsync(on_device.at, &found, sizeof found, cudaMemcpyHostToDevice, c.stream), "copy");
    launch(c, "survey", survey_kernel, at_most(2048, over(in.count, 256)), in, on_device.at);
    found = read_back(c, on_device.at, PBW_STAGE_ORDER, 0.1);
    require(c, found.bad == 0, PBW_ERROR_NOT_FINITE, "a coordinate or weight is not a finite number");
    pbw__grid_share_reset(&range);
    range.unit = found.unit;
    for (int k = 0; k <= in.dim; k++) {
        range.low[k] = unordered(found.low[k]);
        range.high[k] = unordered(found.high[k]);
    }
    return range;
}

/* Sets the units of the space; fails if the device code cannot work in them.  Returns the box of the curve. */
pbw__box measure_space(call &c, const pbw__grid_share &range, int bits, int dim, space &s)
{
    const double weight_range = range.high[dim] - range.low[dim];
    pbw__box domain;
    int exponent;
    pbw__box_reset(&domain, bits);
    pbw__box_add(&domain, range.low, dim);
    pbw__box_add(&domain, range.high, dim);
    pbw__box_close(&domain, dim);
    suit(c, domain.extent > 1e-100 && domain.extent < 1e100,
         "the extent of the points is beyond the range of the device code");
    (void)frexp(domain.extent, &exponent);
    s.unit = ldexp(1.0, 1 - exponent);
    suit(c, weight_range * (s.unit * s.unit) < 1e12, "the weights are beyond the range of the device code");
    s.heaviest = range.high[dim];
    pbw__grid_close(&s.grid, &range, 1, dim);
    for (int k = 0; k < dim; k++) {
        s.low[k] = domain.low[k];
        s.end[k] = domain.high[k];
        s.high[k] = (float)((domain.high[k] - domain.low[k]) * s.unit);
    }
    if (s.grid.inverse_unit > 1e-30 && s.grid.inverse_unit < 1e30) {     /* nothing underflows or overflows */
        double step = s.unit / s.grid.inverse_unit;
        s.exact_height = (dim == 3 ? PBW__EXACT_HEIGHT3 : PBW__EXACT_HEIGHT2) * (step * step);
    }
    return domain;
}

/* Sets duplicates aside: fills id, canonical and the points of s. */
void gather_points(call &c, const ordering &o, space &s, uint32_t *&id, pbw_cuda_mesh *mesh)
{
    const size_t n = o.all.in.count;
    buffer<uint32_t> first(c, n), rank(c);
    launch(c, "places", place_kernel, over(n, 256), o.all, o.root.at, first.at, mesh->canonical, o.found.at);
    mesh->duplicate_count = read_back(c, &o.found.at->duplicates, PBW_STAGE_ORDER, 0.5);
    s.count = (uint32_t)(n - mesh->duplicate_count);
    suit(c, s.count >= PBW_CUDA_FEW, few_points);
    if (s.count < n) {
        rank.make(n);
        sum_before(c, first.at, rank.at, n);
    }
    record *const point = allocate<record>(c, s.count);
    id = allocate<uint32_t>(c, s.count);
    launch(c, "gather", gather_kernel, over(n, 256), o.all, first.at, rank.at, point, id);
    s.point = point;
}

/* Fills s, which was zeros, id and canonical; returns whether weights differ. */
bool order_points(call &c, const input &in, space &s, uint32_t *&id, pbw_cuda_mesh *mesh)
{
    ordering o(c, in);
    const pbw__grid_share range = survey_points(c, in, o.found);
    const pbw__box domain = measure_space(c, range, o.all.bits, in.dim, s);
    o.key = sortable<uint64_t>(c, in.count);
    o.all.key = o.key.array.at;
    launch(c, "keys", key_kernel, over(in.count, 256), o.all, domain);
    sort_keys(c, o.key, in.count, o.sorted_bits());
    o.all.key = o.key.array.at;
    order_runs(c, o);
    gather_points(c, o, s, id, mesh);
    return in.weights != NULL && range.high[in.dim] > range.low[in.dim];
}

void grow_tree(call &c, space &s, int dim, tree &t)
{
    uint32_t size = (s.count + group_size - 1) / group_size;
    float4 *const rough = allocate<float4>(c, s.count);
    s.rough = rough;
    for (t.levels = 0; t.levels == 0 || t.size[t.levels - 1] > 32; size = (size + 31) / 32) {
        box *const b = allocate<box>(c, size);
        if (t.levels == 0) {
            launch(c, "boxes", group_kernel, over(size, 128), s, dim, b, rough, size);
        } else {
            launch(c, "boxes", box_kernel, over(size, 128), t.level[t.levels - 1], t.size[t.levels - 1], b, size);
        }
        t.level[t.levels] = b;
        t.size[t.levels++] = size;
    }
}

/* Looks at 32 boxes or points, of a warp; an insertion counts as 4. */
const int quick_cap = 1024, far_cap = 4096, last_cap[2] = { 1 << 17, 1 << 20 };
const uint32_t last_blocks = 128;

/* Of a star of a sample on the rungs for surfaces: where to stop, and how many there may be of each on average. */
const int sample_cap = 384;
const unsigned long long most_looks = 128;

/* Few points are built soon on any rung. */
const uint32_t sample_size = 1024, sampled_from = 1u << 14;

/* The copy of the points that a mesh keeps is made while the device is at work. */
void keep_points(call &c)
{
    if (c.job->keep != NULL && c.card == 0 && c.job->kept_points == NULL) {
        pbw_status status = c.job->keep(c.job);
        require(c, status == PBW_OK, status, "the points could not be kept");
    }
}

/* The stars of a card's share while the rungs make them. */
struct workshop {
    space s;
    tree t;
    uint32_t *lists;                                 /* of groups near each group of the share */
    near_list *infos;
    store out;
    queue q[3];                                      /* stars for the next rung, in turn; q[2]: large stars */
    unsigned long long *seed;                        /* behind it: looks of a sample */
    uint32_t *next;
    size_t *made;                                    /* stars of each rung */
};

/* Empties the store and the queues. */
void start_over(call &c, const workshop &w)
{
    const uint32_t mine = w.out.end - w.out.first;
    fill(c, w.q[0].count, 0, 3);
    fill(c, w.out.used, 0, 1);
    fill(c, w.out.owned + mine, 0, 1);
    fill(c, w.out.place, 0xff, mine);
}

template <int DIM> void find_seeds(call &c, const workshop &w)
{
    fill(c, w.seed, 0, 4);
    for (int found = 1; found <= DIM; found++) {
        launch(c, "seeds", seed_kernel<DIM>, at_most(1024, over(w.s.count, 256)), w.s, found, w.seed);
    }
}

/* The first rung for total vertices from first on, each stride-th; with EXACT for the first total of q[1]. */
template <int DIM, bool WEIGHTED, bool EXACT>
void launch_near(call &c, const workshop &w, uint32_t first, uint32_t stride, uint32_t total, bool keeps = false)
{
    const size_t bytes = sizeof(near_star<DIM, WEIGHTED, rung_real<EXACT> >) * (near_block / near_lanes);
    static_assert(bytes <= 48 << 10, "the stars of a block fit what every device has of shared memory");
    const near_launch a = { w.s, w.t.level[0], w.lists, w.infos, first, stride, total, keeps, w.out, w.q[0], w.q[1] };
    shape s = over((size_t)total * near_lanes, near_block);
    s.bytes = bytes;
    launch(c, "near stars", near_kernel<DIM, WEIGHTED, EXACT>, s, a);
}

/* Whether a sample shows that the first rung certifies less than half, as where points lie on surfaces and curves and
   spheres are large. */
template <int DIM, bool WEIGHTED> bool sample_reaches_far(call &c, const workshop &w)
{
    start_over(c, w);
    launch_near<DIM, WEIGHTED, false>(c, w, w.out.first, (w.out.end - w.out.first) / sample_size, sample_size);
    const uint2 counts = read_back(c, (const uint2 *)w.q[0].count, PBW_STAGE_BUILD, 0.0);
    if (counts.y == 0 || counts.x + counts.y <= sample_size / 2) {
        return counts.x > sample_size / 2;
    }
    launch_near<DIM, WEIGHTED, true>(c, w, 0, 1, counts.y);
    return read_back(c, w.q[0].count, PBW_STAGE_BUILD, 0.0) > sample_size / 2;
}

/* The first rung: all stars of the share, then those that floats left open.  Returns how many it leaves in q[0]. */
template <int DIM, bool WEIGHTED> uint32_t build_near_stars(call &c, const workshop &w)
{
    const uint32_t chunk = 1u << 22, mine = w.out.end - w.out.first;
    start_over(c, w);
    w.made[0] = mine;
    for (uint32_t first = w.out.first; first < w.out.end; first += chunk) {
        const uint32_t count = w.out.end - first < chunk ? w.out.end - first : chunk;
        const bool more = first + count < w.out.end;
        launch_near<DIM, WEIGHTED, false>(c, w, first, 1, count);
        if (first == w.out.first && more) {          /* one ahead: the host has time for its part */
            continue;
        }
        keep_points(c);
        if (more) {
            wait(c, PBW_STAGE_BUILD, 0.7 * (double)(first - w.out.first) / (double)mine);
        }
    }
    const uint32_t open = read_back(c, w.q[1].count, PBW_STAGE_BUILD, 0.7);
    if (open > 0) {
        launch_near<DIM, WEIGHTED, true>(c, w, 0, 1, open);
    }
    note(c, 3);
    return read_back(c, w.q[0].count, PBW_STAGE_BUILD, 0.8);
}

/* Stars of q[from] by the second or third rung, with at most cap looks each, until more than limit fail.  Returns how
   many it leaves in q[1 - from]. */
template <int DIM, bool WEIGHTED, typename RUNG>
uint32_t run_far_rung(call &c, const workshop &w, int from, uint32_t total, uint32_t limit, int cap)
{
    const uint32_t chunk = 1u << 18, most = RUNG::shared || total < last_blocks ? total : last_blocks;
    const queue &failed = w.q[1 - from];
    buffer<far_star<DIM, WEIGHTED, RUNG> > scratch(c);
    buffer<pbw__digit> pool(c);
    if (total == 0) {
        return 0;
    }
    if (!RUNG::shared) {
        scratch.make(most);
        pool.make((size_t)most * 32 * PBW__POOL);
    }
    fill(c, failed.count, 0, 1);
    for (uint32_t first = 0; first < total; first += chunk) {
        const uint32_t count = total - first < chunk ? total - first : chunk;
        const queue some = { w.q[from].vertex + first, NULL };
        const far_launch a = { w.s, w.t, w.seed, some, count, limit, cap, scratch.at, pool.at, w.out, failed,
                               w.q[2] };
        if (first > 0) {
            wait(c, PBW_STAGE_BUILD, 0.8);
        }
        launch(c, "far stars", far_kernel<DIM, WEIGHTED, RUNG>,
               shape{ count < most ? count : most, 32 * RUNG::warps, RUNG::shared ? sizeof *scratch.at : 0 }, a);
    }
    return read_back(c, failed.count, PBW_STAGE_BUILD, 0.9);
}

/* How many stars may need more than the second rung. */
uint32_t far_limit(const workshop &w)
{
    return 128 + (w.out.end - w.out.first) / 2048;
}

/* The second rung, at first without exact tests, and the third: left stars of q[0].  The few that the third rung
   fails come again with a larger cap. */
template <int DIM, bool WEIGHTED> void build_far_stars(call &c, const workshop &w, uint32_t left)
{
    left = run_far_rung<DIM, WEIGHTED, quick_rung>(c, w, 0, left, none, quick_cap);
    if (left > 0) {
        find_seeds<DIM>(c, w);
    }
    left = run_far_rung<DIM, WEIGHTED, far_rung>(c, w, 1, left, far_limit(w), far_cap);
    w.made[2] = left;
    suit_stars(c, left, far_limit(w));
    left = run_far_rung<DIM, WEIGHTED, last_rung>(c, w, 0, left, last_blocks, last_cap[0]);
    if (left <= last_blocks) {
        left = run_far_rung<DIM, WEIGHTED, last_rung>(c, w, 1, left, 0, last_cap[1]);
    }
    note(c, 4);
    suit_stars(c, left, 0);
}

void lay_bricks(call &c, const space &s, brick_tree &t)
{
    const moments *child = NULL;
    uint32_t size = s.count;
    memset(&t, 0, sizeof t);
    for (; t.levels == 0 || size > 32; t.levels++) {
        const uint32_t children = size;
        size = (size + 7) / 8;
        brick *const b = allocate<brick>(c, size);
        moments *const m = allocate<moments>(c, size);
        launch(c, "bricks", brick_kernel, over(size, 128), s, child, children, m, b, size);
        release(c, child);
        child = m;
        t.level[t.levels] = b;
        t.size[t.levels] = size;
    }
    release(c, child);
    launch(c, "bricks", half_kernel, over(s.count, 256), s, t);
}

/* A rung for surfaces; returns how many stars it leaves. */
template <typename RUNG> uint32_t run_wide_rung(call &c, wide_launch a)
{
    int device = 0, processors = 1;
    buffer<wide_star<RUNG> > scratch(c);
    buffer<pbw__digit> pool(c);
    if (a.total == 0) {
        return 0;
    }
    need(c, cudaGetDevice(&device), "cudaGetDevice");
    need(c, cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device), "cudaDeviceGetAttribute");
    fill(c, a.next, 0, 1);
    fill(c, a.failed.count, 0, 1);
    const unsigned most = RUNG::shared ? (unsigned)(processors * RUNG::blocks) : last_blocks;
    const unsigned blocks = a.total < most ? a.total : most;
    if (!RUNG::shared) {
        scratch.make(blocks);
        pool.make((size_t)blocks * 32 * PBW__POOL);
    }
    a.scratch = scratch.at;
    a.pool = pool.at;
    const shape warps = { blocks, 32 * RUNG::warps, RUNG::shared ? sizeof(wide_star<RUNG>) : 0 };
    launch(c, "stars of a rung", wide_kernel<RUNG>, warps, a);
    keep_points(c);
    return read_back(c, a.failed.count, PBW_STAGE_BUILD, 0.8);
}

/* Whether a sample shows that few stars are large or searched for long.  The CPU takes 150 to 250 ns a point on
   16 threads; 4 warps a multiprocessor take 3 us each for a look at 32 places. */
bool sample_stays_cheap(call &c, const workshop &w, wide_launch a)
{
    a.total = sample_size;
    a.stride = (w.out.end - w.out.first) / sample_size;
    a.work = w.seed + 4;
    a.cap = sample_cap;
    start_over(c, w);
    launch_near<3, false, false>(c, w, w.out.first, a.stride, a.total, true);
    fill(c, a.work, 0, 1);
    const uint32_t failed = run_wide_rung<wide_rung>(c, a);
    const unsigned long long looks = read_back(c, a.work, PBW_STAGE_BUILD, 0.1);
    return failed <= a.total / 64 && looks <= most_looks * a.total;
}

/* Stars that the first rung for surfaces left in q[0]. */
void build_large_wide_stars(call &c, const workshop &w, wide_launch a, uint32_t failed)
{
    a.in = w.out;
    a.stride = 1;
    a.first = 0;
    a.vertex = w.q[0].vertex;
    a.failed = w.q[1];
    a.total = failed;
    a.cap = far_cap;
    a.limit = far_limit(w);
    const uint32_t last = run_wide_rung<large_wide_rung>(c, a);
    suit_stars(c, last, a.limit);                    /* beyond its limit a rung leaves stars untried, uncounted */
    a.vertex = w.q[1].vertex;
    a.failed = w.q[0];
    a.total = last;
    a.cap = last_cap[0];
    a.limit = 0;
    failed = run_wide_rung<last_wide_rung>(c, a);
    w.made[2] = last;
    note(c, 4);
    suit_stars(c, failed, 0);
}

/* Stars of points on surfaces; returns false if a sample speaks against it.  Those that the first rung begins go to a
   store of their own, which is given back. */
bool build_wide_stars(call &c, workshop &w, const brick_tree &bricks)
{
    const uint32_t mine = w.out.end - w.out.first;
    const unsigned long long enough = (unsigned long long)mine * 15 + 4096;
    const store in = w.out;
    wide_launch a = { w.s, bricks, w.seed, NULL, in.first, 1, mine, none, w.next, NULL, quick_cap, NULL, NULL, in, in,
                      w.q[0], w.q[2] };
    find_seeds<3>(c, w);
    if (!sample_stays_cheap(c, w, a)) {
        return false;
    }
    start_over(c, w);
    launch_near<3, false, false>(c, w, in.first, 1, mine, true);
    note(c, 3);
    if (read_back(c, w.out.used, PBW_STAGE_BUILD, 0.2) > w.out.capacity) {
        return true;
    }
    w.out.capacity = w.out.capacity > enough ? w.out.capacity : enough;
    fill(c, w.out.used, 0, 1);
    w.out.word = allocate<uint32_t>(c, (size_t)w.out.capacity * 4);
    a.out = w.out;
    a.limit = 128 + mine / 16;
    const uint32_t failed = run_wide_rung<wide_rung>(c, a);
    const unsigned long long used = read_back(c, w.out.used, PBW_STAGE_BUILD, 0.8);
    release(c, in.word);
    if (used > w.out.capacity) {
        return true;
    }
    w.made[0] = w.made[1] = mine;
    suit_stars(c, failed, a.limit);
    build_large_wide_stars(c, w, a, failed);
    return true;
}

template <int DIM, bool WEIGHTED> void build_stars(call &c, workshop &w)
{
    /* weights hide points, which is quick: no sample */
    const bool far = !WEIGHTED && !pbw_cuda_patient && w.s.count >= sampled_from
                  && w.out.end - w.out.first >= sample_size && sample_reaches_far<DIM, WEIGHTED>(c, w);
    if (far && DIM == 3) {
        brick_tree bricks;
        lay_bricks(c, w.s, bricks);
        const bool built = build_wide_stars(c, w, bricks);
        for (int level = 0; level < bricks.levels; level++) {
            release(c, bricks.level[level]);
        }
        if (built) {
            return;
        }
    }
    suit(c, !far || c.must, "most stars reach far (points on lines, or nearly in a plane?): quicker on the CPU");
    w.made[1] = build_near_stars<DIM, WEIGHTED>(c, w);
    build_far_stars<DIM, WEIGHTED>(c, w, (uint32_t)w.made[1]);
}

/* In parts: memory that is not pinned makes the host wait for each. */
void copy_out(call &c, void *to, const void *from, size_t bytes, double done)
{
    const size_t most = (size_t)1 << 25;
    follow(c);
    for (size_t at = 0; at < bytes; at += most) {
        need(c, cudaMemcpyAsync((char *)to + at, (const char *)from + at, bytes - at < most ? bytes - at : most,
                                cudaMemcpyDeviceToHost, c.copies), "copying results");
        look_up(c, PBW_STAGE_OUTPUT, done);
        go_on(c);
    }
}

/* Lets the other devices read what this one has in its pool, where they can: copies between them go the short way. */
void open_pool(call &c)
{
    offer &own = c.cards->of[c.card];
    cudaMemPool_t pool;
    need(c, cudaDeviceGetMemPool(&pool, own.device), "cudaDeviceGetMemPool");
    for (int i = 0; i < c.cards->cards; i++) {
        const int other = c.cards->of[i].device;
        int can = 0;
        if (other != own.device) {
            need(c, cudaDeviceCanAccessPeer(&can, other, own.device), "cudaDeviceCanAccessPeer");
        }
        if (can) {
            cudaMemAccessDesc access = {};
            access.location.type = cudaMemLocationTypeDevice;
            access.location.id = other;
            access.flags = cudaMemAccessFlagsProtReadWrite;
            can = cudaMemPoolSetAccess(pool, &access, 1) == cudaSuccess;
            (void)cudaGetLastError();
        }
        own.open[i] = (can || other == own.device) && !pbw_cuda_by_host;
    }
}

/* Copies by way of the host what a card offers that this one cannot read; it is complete. */
void fetch_by_host(call &c, int card, char *to, const char *from, size_t bytes)
{
    const size_t most = (size_t)1 << 24;
    void *host = NULL;
    bool done = good(c, cudaMallocHost(&host, bytes < most ? bytes : most), "cudaMallocHost");
    for (size_t at = 0; at < bytes && done; at += most) {
        size_t part = bytes - at < most ? bytes - at : most;
        done = good(c, cudaSetDevice(c.cards->of[card].device), "cudaSetDevice")
            && good(c, cudaMemcpyAsync(host, from + at, part, cudaMemcpyDeviceToHost, cudaStreamPerThread),
                    "copying to the host")
            && good(c, cudaStreamSynchronize(cudaStreamPerThread), "copying to the host");
        done = good(c, cudaSetDevice(c.cards->of[c.card].device), "cudaSetDevice") && done
            && good(c, cudaMemcpyAsync(to + at, host, part, cudaMemcpyHostToDevice, c.stream),
                    "copying from the host")
            && good(c, cudaStreamSynchronize(c.stream), "copying from the host");
    }
    cudaFreeHost(host);
    go_on(c);
}

template <typename V> void fetch_from(call &c, int card, V *to, const void *from, size_t count)
{
    const offer *of = c.cards->of;
    const size_t bytes = count * sizeof(V);
    if (bytes > 0 && !of[card].open[c.card]) {
        fetch_by_host(c, card, (char *)to, (const char *)from, bytes);
    } else if (bytes > 0) {
        need(c, cudaMemcpyPeerAsync(to, of[c.card].device, from, of[card].device, bytes, c.stream),
             "copying between devices");
    }
}

/* The share of a card, by multiprocessors, whole groups: where it begins. */
void share_points(call &c, const space &s, uint32_t &first, uint32_t &end)
{
    double before = 0.0, own = 0.0, all = 0.0;
    for (int i = 0; i < (c.cards != NULL ? c.cards->cards : 1); i++) {
        int processors = 1;
        if (c.cards != NULL) {
            need(c, cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, c.cards->of[i].device),
                 "cudaDeviceGetAttribute");
        }
        before += i < c.card ? processors : 0;
        own += i == c.card ? processors : 0;
        all += processors;
    }
    first = (uint32_t)((double)s.count * (before / all)) / group_size * group_size;
    end = (uint32_t)((double)s.count * ((before + own) / all)) / group_size * group_size;
    end = before + own == all ? s.count : end;
    c.stars = end - first;
}

/* Lists the guests that this card has for higher cards. */
template <int DIM> void list_guests(call &c, const directory<DIM> &all, uint32_t vertices)
{
    offer &own = c.cards->of[c.card];
    if (c.card + 1 == c.cards->cards) {
        return;
    }
    buffer<uint32_t> count(c, (size_t)vertices + 1), place(c, (size_t)vertices + 1);
    fill(c, count.at + vertices, 0, 1);
    for (int i = c.card + 1; i < c.cards->cards; i++) {
        guest_list<DIM> list = { count.at, place.at, NULL, NULL };
        launch(c, "guests", guest_kernel<DIM>, over(vertices, 128), all, vertices, c.cards->of[i].part, list);
        sum_before(c, count.at, place.at, (size_t)vertices + 1);
        own.guest_count[i] = read_back(c, place.at + vertices, PBW_STAGE_OUTPUT, 0.2);
        own.guests[i] = list.guest = allocate<cell<DIM> >(c, own.guest_count[i]);
        own.guest_numbers[i] = list.number = allocate<uint32_t>(c, own.guest_count[i]);
        launch(c, "guests", guest_kernel<DIM>, over(vertices, 128), all, vertices, c.cards->of[i].part, list);
    }
    wait(c, PBW_STAGE_OUTPUT, 0.2);
}

/* Fetches the guests that lower cards have for this one. */
template <int DIM> void fetch_guests(call &c, directory<DIM> &all)
{
    const offer *of = c.cards->of;
    pbw_index *&beyond = c.cards->of[c.card].beyond;
    size_t count = 0;
    for (int i = 0; i < c.card; i++) {
        count += of[i].guest_count[c.card];
    }
    cell<DIM> *const guest = allocate<cell<DIM> >(c, count);
    uint32_t *const number = allocate<uint32_t>(c, count);
    beyond = allocate<pbw_index>(c, count);
    fill(c, beyond, 0xff, count);                    /* guests without a facet here leave theirs */
    all.guest = guest;
    all.guest_number = number;
    for (int i = 0; i < c.card; i++) {
        const uint32_t some = of[i].guest_count[c.card];
        fetch_from(c, i, guest + all.guests, of[i].guests[c.card], some);
        fetch_from(c, i, number + all.guests, of[i].guest_numbers[c.card], some);
        all.guests += some;
    }
}

/* Fetches what higher cards know of this one's simplices. */
template <int DIM> void fetch_beyond(call &c, const directory<DIM> &all, pbw_index *neighbors)
{
    const offer *of = c.cards->of;
    for (int i = c.card + 1; i < c.cards->cards; i++) {
        const uint32_t count = of[c.card].guest_count[i];
        size_t before = 0;
        buffer<pbw_index> beyond(c, count);
        for (int k = 0; k < c.card; k++) {
            before += of[k].guest_count[i];
        }
        fetch_from(c, i, beyond.at, of[i].beyond + before, count);
        launch(c, "neighbours", return_kernel<DIM>, over(count, 128), all, of[i].part, count,
               of[c.card].guest_numbers[i], beyond.at, neighbors);
    }
}

void fetch_incident(call &c, const uint32_t *id, pbw_index *incident)
{
    const offer *of = c.cards->of;
    for (int i = 0; i < c.cards->cards; i++) {
        const uint32_t count = of[i].part.end - of[i].part.first;
        buffer<pbw_index> some(c, count);
        fetch_from(c, i, some.at, of[i].incident, count);
        launch(c, "incident simplices", scatter_kernel, over(count, 256), id + of[i].part.first, count, some.at,
               incident);
    }
}

/* Shares the points, grows the tree, and allocates what the rungs need. */
void open_workshop(call &c, workshop &w, int dim)
{
    share_points(c, w.s, w.out.first, w.out.end);
    const uint32_t mine = w.out.end - w.out.first, groups = (mine + group_size - 1) / group_size;
    w.out.capacity = (unsigned long long)mine * (dim == 3 ? 13 : 5) + 4096;
    /* rough points and boxes; the store, queues, places and counts; lists and their heads of 8 points */
    need_memory(c, (size_t)w.s.count * 16 + (size_t)w.s.count / group_size * sizeof(box) + (size_t)w.out.capacity * 16
                   + (size_t)mine * (12 + 8) + (size_t)groups * (list_size * 4 + sizeof(near_list)));
    grow_tree(c, w.s, dim, w.t);
    uint32_t *const counts = allocate<uint32_t>(c, 5);         /* of the queues, next, stop */
    w.lists = allocate<uint32_t>(c, (size_t)groups * list_size);
    w.infos = allocate<near_list>(c, groups);
    w.out.used = allocate<unsigned long long>(c, 6);
    w.out.place = allocate<uint32_t>(c, mine);
    w.out.owned = allocate<uint32_t>(c, (size_t)mine + 1);
    fill(c, counts + 4, 0, 1);
    for (int i = 0; i < 3; i++) {
        w.q[i].count = counts + i;
        w.q[i].vertex = allocate<uint32_t>(c, mine);
    }
    w.next = counts + 3;
    w.out.stop = counts + 4;
    w.seed = w.out.used + 1;
    if (c.copies != NULL) {
        follow(c);
        c.stop = counts + 4;
    }
    launch(c, "lists", list_kernel, over((size_t)groups * 32, 128), w.t, dim, w.out.first / group_size,
           w.out.first / group_size + groups, w.lists, w.infos);
}

/* All stars into the store, again if it turns out too small. */
template <int DIM, bool WEIGHTED> void fill_store(call &c, workshop &w)
{
    unsigned long long used = 0;
    note(c, 2);
    for (;;) {
        w.out.word = allocate<uint32_t>(c, (size_t)w.out.capacity * 4);
        build_stars<DIM, WEIGHTED>(c, w);
        used = read_back(c, w.out.used, PBW_STAGE_BUILD, 0.95);
        if (used <= w.out.capacity) {
            break;
        }
        release(c, w.out.word);
        w.out.capacity = used + used / 16;
    }
    release(c, w.lists);
    release(c, w.infos);
    require(c, used <= ((unsigned long long)1 << 32) - 16, PBW_ERROR_TOO_LARGE, too_many);
}

/* The simplices of a share on their way out. */
struct output {
    const uint32_t *id;
    bool alone, with_neighbors, to_host;
    uint32_t *offset, total;                         /* of each vertex; of the share */
    size_t before;                                   /* simplices of lower shares */
};

void number_simplices(call &c, const workshop &w, output &o, pbw_cuda_mesh *mesh)
{
    const uint32_t mine = w.out.end - w.out.first;
    o.offset = allocate<uint32_t>(c, (size_t)mine + 1);
    sum_before(c, w.out.owned, o.offset, (size_t)mine + 1);
    o.total = read_back(c, o.offset + mine, PBW_STAGE_OUTPUT, 0.0);
    mesh->simplex_count = o.total;
    if (!o.alone) {
        offer &own = c.cards->of[c.card];
        own.part = { w.out.first, w.out.end };
        own.simplices = o.total;
        meet_cards(c, false, 0.0);
        for (int i = 0; i < c.cards->cards; i++) {
            o.before += i < c.card ? c.cards->of[i].simplices : 0;
            mesh->simplex_count += i != c.card ? c.cards->of[i].simplices : 0;
        }
    }
    note(c, 5);
    require(c, mesh->simplex_count < hidden, PBW_ERROR_TOO_LARGE, too_many);
}

/* Writes the simplices, and lists those that other cards need. */
template <int DIM>
void emit_simplices(call &c, const workshop &w, const output &o, directory<DIM> &all, pbw_cuda_mesh *mesh)
{
    const uint32_t mine = w.out.end - w.out.first;
    const size_t links = (size_t)o.total * (DIM + 1), incident = o.alone ? c.count : mine;
    need_memory(c, (size_t)o.total * (o.with_neighbors ? 3 : 2) * sizeof(cell<DIM>) + c.count * 4);
    cell<DIM> *const cells = allocate<cell<DIM> >(c, o.total);
    mesh->simplices = allocate<pbw_index>(c, links);
    mesh->incident = allocate<pbw_index>(c, incident);
    mesh->neighbors = o.with_neighbors ? allocate<pbw_index>(c, links) : NULL;
    fill(c, mesh->incident, 0xff, incident);
    fill(c, w.next, 0, 1);
    launch(c, "simplices", emit_kernel<DIM>, over((size_t)mine * 8, emit_block), w.out, o.offset, o.id, cells,
           (cell<DIM> *)mesh->simplices);
    note(c, 6);
    all = { w.out.first, (uint32_t)o.before, 0, o.offset, NULL, cells, NULL };
    pbw_status status = o.to_host && c.card == 0 ? c.job->reserve(c.job, mesh->simplex_count) : PBW_OK;
    require(c, status == PBW_OK, status, no_host_memory);
    if (!o.alone) {
        list_guests<DIM>(c, all, mine);
        meet_cards(c, false, 0.1);
        fetch_guests<DIM>(c, all);
    }
    if (o.to_host) {
        copy_out(c, c.job->simplices + o.before * (DIM + 1), mesh->simplices, links * sizeof(pbw_index), 0.1);
    }
}

/* Finds the neighbours and incident simplices; w.next counts hidden points. */
template <int DIM>
void find_neighbors(call &c, const workshop &w, const output &o, const directory<DIM> &all, pbw_cuda_mesh *mesh)
{
    const uint32_t mine = w.out.end - w.out.first;
    const links out = { mesh->neighbors, o.alone ? NULL : c.cards->of[c.card].beyond, mesh->incident,
                        o.alone ? o.id : NULL };
    launch(c, "neighbours", neighbor_kernel<DIM>, over((size_t)mine * 8, emit_block), w.out, all, out, w.next);
    if (mesh->stars[1] > 0) {
        launch(c, "neighbours", large_neighbor_kernel<DIM>, over(mesh->stars[1] * 32, 128), w.q[2], w.out, all, out);
    }
    note(c, 7);
    if (!o.alone) {
        c.cards->of[c.card].incident = mesh->incident;
        wait(c, PBW_STAGE_OUTPUT, 0.2);
        meet_cards(c, false, 0.3);
    }
    if (!o.alone && o.with_neighbors) {
        fetch_beyond<DIM>(c, all, mesh->neighbors);
    }
    if (o.to_host && o.with_neighbors) {
        copy_out(c, c.job->neighbors + o.before * (DIM + 1), mesh->neighbors,
                 (size_t)o.total * (DIM + 1) * sizeof(pbw_index), 0.4);
    }
}

/* The arrays of points: the first card writes the incident simplices of all, the last the canonical points. */
void copy_points(call &c, const output &o, const pbw_cuda_mesh *mesh)
{
    pbw_index *incident = mesh->incident;
    const size_t bytes = c.count * sizeof(pbw_index);
    if (!o.alone && c.card == 0) {
        incident = allocate<pbw_index>(c, c.count);
        fill(c, incident, 0xff, c.count);
        fetch_incident(c, o.id, incident);
    }
    if (o.to_host && c.card == 0) {
        copy_out(c, c.job->incident, incident, bytes, 0.4);
    }
    if (o.to_host && c.card + 1 == c.cards->cards) {
        copy_out(c, c.job->canonical, mesh->canonical, bytes, 0.4);
    }
}

template <int DIM, bool WEIGHTED>
void build(call &c, const space &s, const uint32_t *id, unsigned flags, pbw_cuda_mesh *mesh)
{
    const bool alone = c.cards == NULL || c.cards->cards == 1;
    output o = { id, alone, (flags & PBW_NO_NEIGHBORS) == 0, c.job->reserve != NULL, NULL, 0, 0 };
    workshop w = {};
    directory<DIM> all = {};
    w.s = s;
    w.made = mesh->stars;
    open_workshop(c, w, DIM);
    fill_store<DIM, WEIGHTED>(c, w);
    number_simplices(c, w, o, mesh);
    emit_simplices<DIM>(c, w, o, all, mesh);
    find_neighbors<DIM>(c, w, o, all, mesh);
    copy_points(c, o, mesh);
    mesh->hidden_count = read_back(c, w.next, PBW_STAGE_OUTPUT, 0.5);
}

struct checking {
    call &c;
    view m;
    buffer<double> record;
    buffer<uint32_t> open;                           /* items that the stages without memory leave open */
    buffer<pbw__digit> pool;
    buffer<check_result> on_device;
    check_result found;
    uint32_t points;                                 /* of a pass */
    pbw_report *report;                              /* NULL: only whether there is a fault */
    checking(call &of, const pbw_cuda_mesh &mesh, const input &in, const pbw__grid &grid, pbw_report *to)
        : c(of), record(of, in.count * (size_t)(in.dim + 1)),
          open(of, mesh.simplex_count > in.count ? mesh.simplex_count : in.count),
          pool(of, (size_t)check_blocks * 32 * PBW__POOL), on_device(of, 1), points((uint32_t)in.count), report(to)
    {
        (pbw__tested &)m = { mesh.simplices, mesh.neighbors, mesh.incident, mesh.canonical, record.at, in.count,
                             mesh.simplex_count, grid, in.dim, to == NULL };
        m.order = NULL;
        found = check_result();
        found.least = ~0ull;
        need(c, cudaMemcpyAsync(on_device.at, &found, sizeof found, cudaMemcpyHostToDevice, c.stream), "copy");
        launch(c, "check", record_kernel, over(in.count, 256), in, record.at);
    }
};

/* Items by the threads of a shape; list: NULL if they are all; pool: NULL without the exact stage. */
template <int DIM>
void check_items(checking &k, int pass, uint32_t count, shape threads, const uint32_t *list, pbw__digit *pool)
{
    launch(k.c, "check", check_kernel<DIM>, threads, k.m, pass, count, list, k.open.at, pool, k.on_device.at);
    k.found = read_back(k.c, k.on_device.at, PBW_STAGE_BUILD, 0.0);
}

/* One pass; returns false if there is a fault, which the report then names. */
template <int DIM> bool check_pass(checking &k, int pass)
{
    call &c = k.c;
    const bool of_points = pass == check_points || pass == check_hidden;
    const uint32_t count = of_points ? k.points : (uint32_t)k.m.simplex_count;
    check_items<DIM>(k, pass, count, at_most(1u << 16, over(count, 128)), NULL, NULL);
    if (k.found.open > 0) {
        check_items<DIM>(k, pass, k.found.open, shape{ check_blocks, 32, 0 }, k.open.at, k.pool.at);
        fill(c, &k.on_device.at->open, 0, 1);
    }
    if (k.found.least != ~0ull && k.report != NULL) {      /* once more, for a description of it */
        const uint32_t item = (uint32_t)(k.found.least >> 32);
        need(c, cudaMemcpyAsync(k.open.at, &item, sizeof item, cudaMemcpyHostToDevice, c.stream), "copy");
        check_items<DIM>(k, pass, 1, shape{ 1, 32, 0 }, k.open.at, k.pool.at);
        const pbw__finding &first = k.found.first;
        (void)pbw__fault(k.report, first.fault, first.simplex, first.facet, first.point);
    }
    return k.found.least == ~0ull;
}

bool miscounts(pbw_report *report, size_t said, size_t counted, int fault)
{
    return said != counted && !pbw__fault(report, fault, PBW_NONE, -1, PBW_NONE);
}

template <int DIM> bool check_mesh(call &c, const pbw_cuda_mesh &mesh, const input &in, pbw_report *report)
{
    buffer<survey> surveyed(c, 1);
    const pbw__grid_share range = survey_points(c, in, surveyed);
    pbw__grid grid;
    pbw__grid_close(&grid, &range, 1, in.dim);
    checking k(c, mesh, in, grid, report);
    if (!check_pass<DIM>(k, check_points)) {
        return false;
    }
    const size_t others = (size_t)k.found.counted[check_points][1];
    report->vertex_count = (size_t)k.found.counted[check_points][0];
    if (miscounts(report, mesh.duplicate_count, (size_t)k.found.counted[check_points][2], PBW__FAULT_DUPLICATES)
        || miscounts(report, mesh.hidden_count, others, PBW__FAULT_HIDDEN)
        || !check_pass<DIM>(k, check_simplices)) {
        return false;
    }
    report->facet_count = (size_t)k.found.counted[check_simplices][0];
    report->hull_facet_count = (size_t)k.found.counted[check_simplices][1];
    return check_pass<DIM>(k, check_hull) && (others == 0 || check_pass<DIM>(k, check_hidden));
}

const int mesh_arrays = 4;

pbw_index *&array_of(pbw_cuda_mesh &mesh, int i)
{
    return i == 0 ? mesh.simplices : i == 1 ? mesh.neighbors : i == 2 ? mesh.incident : mesh.canonical;
}

size_t entries_of(const pbw_cuda_mesh &mesh, int i)
{
    return i < 2 ? mesh.simplex_count * (size_t)(mesh.dim + 1) : mesh.point_count;
}

/* The arrays of a mesh leave the blocks of the call. */
void release_mesh(call &c, pbw_cuda_mesh mesh, bool keep)
{
    for (int i = 0; i < mesh_arrays; i++) {
        release(c, array_of(mesh, i), keep);
    }
}

/* The last mesh of a loop becomes the call's: where the call fails, it frees that too. */
void adopt_last(call &c)
{
    for (int i = 0; i < mesh_arrays; i++) {
        if (array_of(c.last->mesh, i) != NULL) {
            own(c, array_of(c.last->mesh, i), entries_of(c.last->mesh, i) * sizeof(pbw_index));
        }
    }
    if (c.last->id != NULL) {
        own(c, c.last->id, c.last->count * sizeof(uint32_t));
    }
}

/* Whether an earlier mesh, whose links are sound, is the triangulation of the points where they are now, of which the
   duplicates are those of the mesh; id: of each rank. */
template <int DIM>
bool holds(call &c, const pbw_cuda_mesh &mesh, const input &in, const space &s, const uint32_t *id)
{
    checking k(c, mesh, in, s.grid, NULL);
    k.m.order = id;
    k.points = s.count;
    return check_pass<DIM>(k, check_simplices) && check_pass<DIM>(k, check_hull)
        && (mesh.hidden_count == 0 || check_pass<DIM>(k, check_hidden));
}

/* Writes the arrays of old in the order that the points have now. */
template <int DIM>
void reorder_mesh(call &c, const pbw_cuda_mesh &old, const space &s, const uint32_t *id, pbw_cuda_mesh *mesh)
{
    const size_t count = old.simplex_count, links = count * (DIM + 1);
    const shape all = over(count, 256);
    const int bits = pbw__index_bits(s.count);
    buffer<uint32_t> rank(c, old.point_count);
    sortable<uint32_t> third(c, count), order(c, count);
    sortable<uint64_t> first(c, count);
    const reorder m = { old.simplices, old.neighbors, id, rank.at, (uint32_t)count, bits };
    mesh->simplices = allocate<pbw_index>(c, links);
    mesh->neighbors = allocate<pbw_index>(c, links);
    mesh->incident = allocate<pbw_index>(c, old.point_count);
    fill(c, mesh->incident, 0xff, old.point_count);
    launch(c, "order", scatter_kernel, over(s.count, 256), id, s.count, nullptr, rank.at);
    launch(c, "order", third_kernel<DIM>, all, m, third.array.at, order.array.at);
    sort_pairs(c, third, order, count, { 0, bits });
    launch(c, "order", first_kernel<DIM>, all, m, order.array.at, first.array.at);
    sort_pairs(c, first, order, count, { 0, 2 * bits });
    launch(c, "order", scatter_kernel, all, order.array.at, m.count, nullptr, order.spare.at);
    launch(c, "order", rewrite_kernel<DIM>, all, m, order.array.at, order.spare.at, mesh->simplices, mesh->neighbors,
           mesh->incident);
}

/* Makes the mesh of the last one, if that holds. */
template <int DIM>
bool keep_mesh(call &c, const pbw_cuda_mesh &old, const input &in, const space &s, const uint32_t *id,
               pbw_cuda_mesh *mesh)
{
    const bool ordered_alike = c.last->count == s.count;
    buffer<uint2> flags(c, 1);                       /* whether duplicates differ, and the order */
    fill(c, flags.at, 0, 1);
    launch(c, "order", compare_kernel, over(in.count, 256), old.canonical, mesh->canonical, (uint32_t)in.count,
           &flags.at->x);
    if (ordered_alike) {
        launch(c, "order", compare_kernel, over(s.count, 256), c.last->id, id, s.count, &flags.at->y);
    }
    const uint2 differ = read_back(c, flags.at, PBW_STAGE_BUILD, 0.0);
    if (differ.x != 0 || !holds<DIM>(c, old, in, s, id)) {
        return false;
    }
    if (ordered_alike && differ.y == 0) {
        mesh->simplices = old.simplices;
        mesh->neighbors = old.neighbors;
        mesh->incident = old.incident;
    } else {
        reorder_mesh<DIM>(c, old, s, id, mesh);
    }
    mesh->simplex_count = old.simplex_count;
    mesh->hidden_count = old.hidden_count;
    mesh->kept = 1;
    note(c, 7);
    wait(c, PBW_STAGE_OUTPUT, 0.5);
    return true;
}

/* The same for any call; frees a last mesh that does not hold. */
bool keep_last(call &c, const input &in, const space &s, uint32_t *id, pbw_cuda_mesh *mesh)
{
    if (c.last == NULL) {
        return false;
    }
    const pbw_cuda_mesh old = c.last->mesh;
    const bool alike = !c.anew && old.simplex_count > 0 && old.neighbors != NULL && old.dim == in.dim
                    && old.point_count == in.count && old.duplicate_count == mesh->duplicate_count;
    const bool kept = alike && (in.dim == 3 ? keep_mesh<3> : keep_mesh<2>)(c, old, in, s, id, mesh);
    if (!kept) {
        release_mesh(c, old, false);
    }
    release(c, c.last->id);
    c.last->id = id;
    c.last->count = s.count;
    return kept;
}

void run(call &c, const input &in, unsigned flags, pbw_cuda_mesh *mesh)
{
    space s = {};
    uint32_t *id = NULL;
    mesh->dim = in.dim;
    mesh->point_count = in.count;
    suit(c, in.count >= PBW_CUDA_FEW, few_points);
    suit(c, in.count < (size_t)1 << 31, "too many points for the device code");
    note(c, 0);
    mesh->canonical = allocate<pbw_index>(c, in.count);
    const bool weighted = order_points(c, in, s, id, mesh);
    release(c, in.points);                           /* those of a job: the records have all */
    release(c, in.weights);
    note(c, 1);
    if (!keep_last(c, in, s, id, mesh)) {
        (in.dim == 3 ? (weighted ? build<3, true> : build<3, false>)
                     : (weighted ? build<2, true> : build<2, false>))(c, s, id, flags, mesh);
    }
    for (int i = 0; i < 8; i += mesh->kept ? 7 : 1) {
        need(c, cudaEventElapsedTime(&mesh->milliseconds[i], c.mark[i < 7 ? i : 0], c.mark[i < 7 ? i + 1 : 7]),
             "cudaEventElapsedTime");
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>entry        The backend, and the entries for points on the device.
   ------------------------------------------------------------------------------------------------------ */
/* count: the points to triangulate; 0 in a check. */
void open_call(call &c, cudaStream_t stream, int dim, size_t count)
{
    int device = 0, pools = 0;
    c.stream = stream;
    c.dim = dim;
    c.count = count;
    c.stars = count / (c.cards != NULL ? (size_t)c.cards->cards : 1);
    need(c, cudaGetDevice(&device), "no usable device");
    need(c, cudaDeviceGetAttribute(&pools, cudaDevAttrMemoryPoolsSupported, device), "cudaDeviceGetAttribute");
    require(c, pools != 0, PBW_ERROR_BACKEND, "the device or its driver has no memory pools");
    if (!c.lent) {
        need(c, cudaDeviceGetMemPool(&c.pool, device), "cudaDeviceGetMemPool");
        for (int i = 0; i < 8; i++) {
            need(c, cudaEventCreate(&c.mark[i]), "cudaEventCreate");
        }
        need(c, cudaEventCreateWithFlags(&c.ready, cudaEventDisableTiming), "cudaEventCreate");
        need(c, cudaEventCreateWithFlags(&c.copied, cudaEventDisableTiming), "cudaEventCreate");
    }
}

void destroy_events(const gear &g)
{
    for (int i = 0; i < 10; i++) {
        cudaEvent_t event = i < 8 ? g.mark[i] : i == 8 ? g.ready : g.copied;
        if (event != NULL) {
            cudaEventDestroy(event);
        }
    }
}

void open_stream(call &c, cudaStream_t &stream)
{
    need(c, cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "cudaStreamCreate");
}

/* Frees all but what the mesh, if there is one, has; the stream may still have work for it. */
void close_call(call &c, const pbw_cuda_mesh *mesh)
{
    if (mesh != NULL) {
        release_mesh(c, *mesh, true);
    }
    while (c.blocks > 0) {
        release(c, c.block[0].address);
    }
    if (!c.lent) {
        destroy_events(c);
    }
    (void)cudaGetLastError();
}

size_t number_size(bool is_float)
{
    return is_float ? sizeof(float) : sizeof(double);
}

bool is_packed(const pbw_job *job)
{
    const size_t size = number_size(job->is_float);
    return job->stride == (size_t)job->dim * size && (job->weights == NULL || job->weight_stride == size);
}

/* Returns the input of a job, on the device; strided input has been packed. */
input upload(call &c)
{
    const pbw_job *job = c.job;
    const bool packed = is_packed(job);
    const void *from[2] = { packed ? job->points : job->kept_points, packed ? job->weights : job->kept_weights };
    input in = { NULL, NULL, job->count, job->dim, packed && job->is_float };
    for (int part = 0; part < 2 && from[part] != NULL; part++) {
        const size_t bytes = job->count * number_size(in.is_float) * (part == 0 ? (size_t)job->dim : 1);
        char *const on_device = allocate<char>(c, bytes);
        need(c, cudaMemcpyAsync(on_device, from[part], bytes, cudaMemcpyHostToDevice, c.stream), "copying points");
        (part == 0 ? in.points : in.weights) = on_device;
    }
    return in;
}

/* A card's part in a job. */
void take_part(team *cards, int card, pbw_job *job, pbw_cuda_mesh *mesh)
{
    cudaStream_t stream = NULL;
    call c = call();
    c.cards = cards;
    c.card = card;
    c.job = job;
    try {
        need(c, cudaSetDevice(cards->of[card].device), "cudaSetDevice");
        open_stream(c, stream);
        open_call(c, stream, job->dim, job->count);
        open_stream(c, c.copies);
        open_pool(c);
        run(c, upload(c), job->flags, mesh);
    } catch (const failure &) {
        fall_out(c, NULL);
    }
    if (c.copies != NULL) {                          /* they must end before the job's memory may be freed */
        finish_stream(c, c.copies, PBW_STAGE_OUTPUT, 0.8);
        good(c, cudaStreamSynchronize(c.copies), "copying results");
        cudaStreamDestroy(c.copies);
    }
    if (stream != NULL) {
        good(c, cudaStreamSynchronize(stream), "waiting for the device");
    }
    fall_out(c, NULL);
    meet_cards(c, true, 0.9);
    close_call(c, NULL);
    if (stream != NULL) {
        good(c, cudaStreamSynchronize(stream), "waiting for the device");
        cudaStreamDestroy(stream);
    }
}

struct device_list {
    pbw_backend backend;
    int count, device[most_cards];
    device_list *next;
};

pbw_status triangulate(const pbw_backend *backend, pbw_job *job)
{
    const device_list &list = *(const device_list *)backend->user;
    int before = 0, devices = 0, helpers = 0;
    cudaError_t error = cudaGetDeviceCount(&devices);
    pbw_cuda_mesh mesh[most_cards] = {};
    std::thread helper[most_cards];
    team cards;
    char text[128];
    cards.cards = list.count;
    if (job->count < PBW_CUDA_FEW) {
        job->say(job, few_points);
        job->declined = 1;
        return PBW_ERROR_BACKEND;
    }
    for (int i = 0; i < list.count; i++) {
        cards.of[i].device = list.device[i];
        if (error != cudaSuccess || list.device[i] >= devices) {
            snprintf(text, sizeof text, "device %d: %s", list.device[i],
                     error != cudaSuccess ? cudaGetErrorString(error) : "there is no such device");
            job->say(job, text);
            return PBW_ERROR_BACKEND;
        }
    }
    if (!is_packed(job)) {
        pbw_status status = job->keep(job);
        if (status != PBW_OK) {
            return status;
        }
    }
    cudaGetDevice(&before);
    try {
        for (; helpers + 1 < list.count; helpers++) {
            helper[helpers] = std::thread(take_part, &cards, helpers + 1, job, &mesh[helpers + 1]);
        }
    } catch (...) {
        std::lock_guard<std::mutex> hold(cards.lock);
        cards.cards = helpers + 1;
        cards.status = PBW_ERROR_THREAD;
    }
    take_part(&cards, 0, job, &mesh[0]);
    for (int i = 0; i < helpers; i++) {
        helper[i].join();
    }
    cudaSetDevice(before);
    job->duplicate_count = mesh[0].duplicate_count;
    for (int i = 0; i < list.count; i++) {
        job->hidden_count += mesh[i].hidden_count;
    }
    job->declined = cards.declined;
    return (pbw_status)cards.status.load();
}

/* A call for points on the device: a job whose results stay there. */
struct local_call {
    call c;
    pbw_job job;
    pbw__context context;
    pbw__dispatch dispatch;
    pbw__fp fp;
};

bool take_options(pbw_options &options, const pbw_options *given_options)
{
    options = given_options != NULL ? *given_options : pbw_options();
    return options.threads >= 0 && options.threads <= 256
        && (options.flags & ~(PBW_ANY_ORDER | PBW_NO_NEIGHBORS | PBW_BACKEND_OR_CPU)) == 0;
}

int report_check(pbw_job *job, pbw_stage stage, double done)
{
    (void)stage;
    return pbw__job_report(job, PBW_STAGE_CHECK, done);
}

/* What a call for points on the device is to do, and with what. */
struct request {
    input in;
    cudaStream_t stream;
    pbw_triangulator *cpu;
    keepsake *last;                                  /* of a loop, with its gear; else NULL */
    const gear *tools;
    bool anew, check;
    pbw_options options;
};

void open_local(local_call &local, const request &r)
{
    const pbw_options &options = r.options;
    call &c = local.c;
    memset(&local, 0, sizeof local);
    pbw__context_start(&local.context, &options, r.check ? 0 : r.in.count);
    local.dispatch.context = &local.context;
    local.dispatch.options = &options;
    local.job.memory_limit = options.memory_limit;
    local.job.report = r.check ? report_check : pbw__job_report;
    local.job.say = pbw__job_say;
    local.job.context = &local.dispatch;
    c.job = &local.job;
    c.must = r.cpu == NULL;
    if (r.last != NULL) {
        (gear &)c = *r.tools;
        c.lent = true;
        c.anew = r.anew;
        c.last = r.last;
        adopt_last(c);
    }
    local.fp = pbw__fp_enter();
    require(c, pbw__fp_is_exact(), PBW_ERROR_FP_MODE, pbw_status_string(PBW_ERROR_FP_MODE));
    look_up(c, PBW_STAGE_ORDER, 0.0);
    go_on(c);
    open_call(c, r.stream, r.in.dim, r.check ? 0 : r.in.count);
    if (options.progress != NULL && !c.lent) {
        open_stream(c, c.copies);
    }
}

/* On success all but the mesh's arrays is freed, else those too. */
pbw_status close_local(local_call &local, pbw_cuda_mesh *mesh)
{
    call &c = local.c;
    if (c.copies != NULL) {                          /* the word that stops kernels is written before it is freed */
        good(c, cudaStreamSynchronize(c.copies), "stopping");
        if (!c.lent) {
            cudaStreamDestroy(c.copies);
        }
    }
    const bool failed = c.status != PBW_OK && c.status != PBW_DEGENERATE;
    if (mesh != NULL && failed) {
        memset(mesh, 0, sizeof *mesh);               /* everything is still in the list of blocks */
    }
    if (c.last != NULL && failed) {
        memset(c.last, 0, sizeof *c.last);
    } else if (c.last != NULL) {
        c.last->mesh = *mesh;
        release(c, c.last->id, true);
    }
    close_call(c, mesh);
    pbw__fp_leave(local.fp);
    return c.status;
}

/* Fetches the points of an input as doubles; floats come to lie in the second half, and are widened in place. */
void fetch_points(call &c, const input &in, double *points, size_t numbers)
{
    const size_t size = number_size(in.is_float), bytes = in.count * (size_t)in.dim * size;
    char *packed = (char *)(points + numbers) - numbers * size;
    need(c, cudaMemcpyAsync(packed, in.points, bytes, cudaMemcpyDeviceToHost, c.stream), "copying points");
    if (in.weights != NULL) {
        need(c, cudaMemcpyAsync(packed + bytes, in.weights, in.count * size, cudaMemcpyDeviceToHost, c.stream),
             "copying weights");
    }
    wait(c, PBW_STAGE_ORDER, 0.0);
    for (size_t i = 0; i < numbers && in.is_float; i++) {
        float number;
        memcpy(&number, packed + i * sizeof number, sizeof number);
        points[i] = (double)number;
    }
}

/* Copies a mesh of the CPU to the device. */
void send_mesh(call &c, const pbw_mesh &host, const input &in, pbw_cuda_mesh *mesh)
{
    const pbw_index *from[mesh_arrays] = { host.simplices, host.neighbors, host.incident, host.canonical };
    mesh->dim = in.dim;
    mesh->by_cpu = 1;
    mesh->point_count = in.count;
    mesh->simplex_count = host.simplex_count;
    mesh->duplicate_count = host.duplicate_count;
    mesh->hidden_count = host.hidden_count;
    for (int i = 0; i < mesh_arrays; i++) {
        if (from[i] != NULL) {
            array_of(*mesh, i) = allocate<pbw_index>(c, entries_of(*mesh, i));
            need(c, cudaMemcpyAsync(array_of(*mesh, i), from[i], entries_of(*mesh, i) * sizeof(pbw_index),
                                    cudaMemcpyHostToDevice, c.stream), "copying results");
        }
    }
}

/* An input on the device that is for the CPU: its points to the host, the arrays to the device. */
void build_by(pbw_triangulator *cpu, call &c, const input &in, pbw_options options, pbw_cuda_mesh *mesh)
{
    pbw__memory &memory = ((pbw__dispatch *)c.job->context)->context->memory;
    const size_t coordinates = in.count * (size_t)in.dim, numbers = coordinates + (in.weights != NULL ? in.count : 0);
    double *points = (double *)pbw__allocate(&memory, numbers, sizeof(double));
    pbw_mesh host = {};
    pbw_status status = PBW_OK;
    require(c, points != NULL, PBW_ERROR_MEMORY, no_host_memory);
    options.backend = NULL;
    options.trace = NULL;
    options.stride = options.weight_stride = 0;
    options.memory_limit -= options.memory_limit > 0 ? memory.used - (memory.used == memory.limit) : 0;
    try {
        fetch_points(c, in, points, numbers);
        status = cpu(in.dim, points, in.weights != NULL ? points + coordinates : NULL, in.count, &options, &host);
        require(c, status == PBW_OK || status == PBW_DEGENERATE, status, pbw_status_string(status));
        send_mesh(c, host, in, mesh);
    } catch (const failure &) {
    }
    finish_stream(c, c.stream, PBW_STAGE_OUTPUT, 0.9);      /* the host arrays are freed next */
    c.status = c.status == PBW_OK ? status : c.status;
    pbw_free(&host);
    pbw__release(&memory, points, numbers, sizeof(double));
}

/* Builds a mesh, by the CPU where that is what the caller wants. */
pbw_status serve(request &r, const pbw_options *given_options, pbw_cuda_mesh *mesh)
{
    const size_t size = number_size(r.in.is_float);
    pbw_status status = PBW_ERROR_BACKEND;
    if (mesh == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(mesh, 0, sizeof *mesh);
    if (!take_options(r.options, given_options) || (r.in.dim != 2 && r.in.dim != 3)
        || (r.in.points == NULL && r.in.count > 0)
        || (r.options.stride != 0 && r.options.stride != (size_t)r.in.dim * size)
        || (r.options.weight_stride != 0 && r.options.weight_stride != size)) {
        return PBW_ERROR_ARGUMENT;
    }
    if (r.in.count >= PBW_NONE) {
        return PBW_ERROR_TOO_LARGE;
    }
    for (int on_cpu = 0; on_cpu < 2 && status == PBW_ERROR_BACKEND; on_cpu++) {
        local_call local;
        call &c = local.c;
        try {
            open_local(local, r);
            if (on_cpu) {
                build_by(r.cpu, c, r.in, r.options, mesh);
            } else {
                run(c, r.in, r.options.flags, mesh);
            }
            look_up(c, PBW_STAGE_OUTPUT, 1.0);
        } catch (const failure &) {
        }
        status = close_local(local, mesh);
        if (r.cpu == NULL || (!c.declined && (r.options.flags & PBW_BACKEND_OR_CPU) == 0)) {
            break;
        }
    }
    return status;
}

} /* namespace */

extern "C" const pbw_backend *pbw_cuda_backend_multi(const int *devices, int count)
{
    static std::mutex lock;
    static device_list *lists = NULL;                /* one for each list of devices seen so far */
    device_list *list;
    if (count < 1 || count > most_cards || *std::min_element(devices, devices + count) < 0) {
        return NULL;
    }
    std::lock_guard<std::mutex> hold(lock);
    for (list = lists; list != NULL; list = list->next) {
        if (list->count == count && memcmp(list->device, devices, (size_t)count * sizeof *devices) == 0) {
            return &list->backend;
        }
    }
    list = (device_list *)malloc(sizeof *list);
    if (list == NULL) {
        return NULL;
    }
    *list = device_list{ { PBW_VERSION, triangulate, list }, count, {}, lists };
    memcpy(list->device, devices, (size_t)count * sizeof *devices);
    lists = list;
    return &list->backend;
}

extern "C" const pbw_backend *pbw_cuda_backend(int device)
{
    return pbw_cuda_backend_multi(&device, 1);
}

extern "C" pbw_status pbw_cuda_triangulate(int dim, int is_float, const void *points, const void *weights,
                                           size_t count, const pbw_options *given_options, void *stream,
                                           pbw_triangulator *cpu, pbw_cuda_mesh *mesh)
{
    request r = { { points, weights, count, dim, is_float }, (cudaStream_t)stream, cpu };
    return serve(r, given_options, mesh);
}

extern "C" void pbw_cuda_free(pbw_cuda_mesh *mesh, void *stream)
{
    if (mesh != NULL) {
        for (int i = 0; i < mesh_arrays; i++) {
            if (array_of(*mesh, i) != NULL) {
                cudaFreeAsync(array_of(*mesh, i), (cudaStream_t)stream);
            }
        }
        memset(mesh, 0, sizeof *mesh);
    }
}

extern "C" pbw_status pbw_cuda_check(const pbw_cuda_mesh *mesh, int is_float, const void *points, const void *weights,
                                     const pbw_options *given_options, void *stream, pbw_report *report)
{
    request r = { { points, weights, 0, 0, is_float }, (cudaStream_t)stream, NULL, NULL, NULL, false, true };
    local_call local;
    if (report != NULL) {
        memset(report, 0, sizeof *report);
        (void)pbw__fault(report, PBW__SOUND, PBW_NONE, -1, PBW_NONE);
    }
    if (!take_options(r.options, given_options) || report == NULL || mesh == NULL || points == NULL
        || (mesh->dim != 2 && mesh->dim != 3)
        || mesh->simplex_count == 0 || mesh->simplex_count >= PBW_NONE || mesh->point_count >= PBW_NONE
        || mesh->simplices == NULL || mesh->neighbors == NULL || mesh->incident == NULL || mesh->canonical == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    r.in.dim = mesh->dim;
    r.in.count = mesh->point_count;
    try {
        open_local(local, r);
        report->valid = (mesh->dim == 3 ? check_mesh<3> : check_mesh<2>)(local.c, *mesh, r.in, report);
        look_up(local.c, PBW_STAGE_CHECK, 1.0);
    } catch (const failure &) {
    }
    return close_local(local, NULL);
}

struct pbw_cuda_loop {
    int device;
    cudaStream_t stream;
    pbw_options options;
    pbw_triangulator *cpu;
    gear tools;
    keepsake last;
};

extern "C" pbw_status pbw_cuda_loop_create(const pbw_options *given_options, void *stream, pbw_triangulator *cpu,
                                           pbw_cuda_loop **result)
{
    request r = { { NULL, NULL, 0, 3, 0 }, (cudaStream_t)stream, cpu };
    uint64_t all = UINT64_MAX;
    cudaMemPoolProps properties = {};
    cudaMemPool_t pool = NULL;
    local_call local;
    pbw_cuda_loop *loop = NULL;
    if (result == NULL || !take_options(r.options, given_options)) {
        return PBW_ERROR_ARGUMENT;
    }
    const pbw_options options = r.options;
    call &c = local.c;
    *result = NULL;
    r.options.progress = NULL;
    try {
        open_local(local, r);
        properties.allocType = cudaMemAllocationTypePinned;
        properties.location.type = cudaMemLocationTypeDevice;
        loop = (pbw_cuda_loop *)pbw__allocate(&local.context.memory, 1, sizeof *loop);
        require(c, loop != NULL, PBW_ERROR_MEMORY, no_host_memory);
        need(c, cudaGetDevice(&properties.location.id), "cudaGetDevice");
        need(c, cudaMemPoolCreate(&pool, &properties), "cudaMemPoolCreate");
        need(c, cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &all), "the pool");
        open_stream(c, c.copies);
        need(c, cudaMallocHost(&c.pinned, pinned_bytes), "cudaMallocHost");
        c.pool = pool;
        c.lent = true;
        *loop = pbw_cuda_loop{ properties.location.id, r.stream, options, cpu, c, keepsake() };
    } catch (const failure &) {
        if (pool != NULL) {
            cudaMemPoolDestroy(pool);
        }
        pbw__release(&local.context.memory, loop, 1, sizeof *loop);
        loop = NULL;
    }
    *result = loop;
    return close_local(local, NULL);
}

extern "C" pbw_status pbw_cuda_loop_step(pbw_cuda_loop *loop, const pbw_cuda_points *points, pbw_cuda_mesh *mesh)
{
    int device = -1;
    if (mesh != NULL) {
        memset(mesh, 0, sizeof *mesh);
    }
    if (loop == NULL || points == NULL || mesh == NULL || cudaGetDevice(&device) != cudaSuccess
        || device != loop->device) {
        (void)cudaGetLastError();
        return PBW_ERROR_ARGUMENT;
    }
    request r = { { points->points, points->weights, points->count, points->dim, points->is_float }, loop->stream,
                  loop->cpu, &loop->last, &loop->tools, points->anew != 0 };
    return serve(r, &loop->options, mesh);
}

extern "C" void pbw_cuda_loop_free(pbw_cuda_loop *loop)
{
    if (loop != NULL) {
        pbw__memory memory;
        cudaFreeAsync(loop->last.id, loop->stream);
        pbw_cuda_free(&loop->last.mesh, loop->stream);
        cudaStreamSynchronize(loop->stream);
        if (loop->tools.copies != NULL) {
            cudaStreamDestroy(loop->tools.copies);
        }
        destroy_events(loop->tools);
        cudaFreeHost(loop->tools.pinned);
        cudaMemPoolDestroy(loop->tools.pool);
        (void)cudaGetLastError();
        pbw__memory_start(&memory, &loop->options);
        memory.used = sizeof *loop;
        pbw__release(&memory, loop, 1, sizeof *loop);
    }
}
