/* pbw_cuda.cu - the triangulation of pbw.h on an NVIDIA GPU - MIT-0

   Build:  nvcc -O3 -I. -Iexamples/lib -c pbw_cuda.cu, or without -I beside pbw.h and pbw_check.h
           (compute capability 7.0 or later; CUDA 11.7 or later)
   Use:    options.backend = pbw_cuda_backend(0), or pbw_cuda_backend_multi for several devices,
           or pbw_cuda_triangulate for points on the device, or pbw_cuda_loop_step for points that move;
           pbw_cuda_cells_of for the Voronoi or power cells of points on the device, pbw_cuda_cells_of_host for those
           of points in the memory of the host.

   The result equals that of the CPU byte for byte, because it is a function of the points alone (see CONVENTIONS in
   pbw.h) and every sign that it depends on is exact.

   CERTIFIED LOCAL STARS.  The star of each vertex v is built alone.
     1. As in Bowyer-Watson, points near v are inserted, but only the simplices around v are kept: a new point
        replaces those in conflict with it by the fan from it to their border.
     2. Let no other point of the input be in conflict with any simplex of the star.  Then each of them belongs to the
        one perturbed triangulation, and together they surround v: the star is certified, it is that of the result.
     3. Each simplex is written by its lowest vertex.
     4. Its neighbour across a facet is found in the star of the facet's lowest vertex.
   So no star depends on another while it is built.

     first rung    8 lanes a star; candidates from a list of groups of points near v; certified if the spheres of the
                   star lie within the box that the list covers.  About 97 of 100 stars of uniform points.
     second rung   a warp a star; candidates from a search of the box tree for points in conflict with the simplices
                   that the first rung left uncertified.  Stars of the hull, of sparse places, larger stars.  At first
                   by floats and, where they leave a sign open, doubles; then with exact tests and more room.
     third rung    like the second, with room for 1000 vertices and with the last exact stage of pbw.h.  A handful of
                   stars; the few that reach the cap on their search get a much larger one once.
     the CPU       takes the whole input if a star fits no rung, if the points are few, or if a sample of stars
                   predicts that the CPU is faster.  (Stars are too large where points are on lines, and too flat for
                   floats where they are nearly in a plane; if all are near one sphere, each circumsphere passes near
                   all of them.)  Points on the device are then copied to the host, and the arrays back.  If the
                   caller names no CPU, the rungs above build the stars or the call fails.

   Unweighted points in space on surfaces (scans, terrain) have rungs of their own, >>wide, which search another tree.
   They are recognised by a sample of 1024 stars of which the first rung certifies less than half.

   SEVERAL DEVICES.
     1. Every card puts all points into order: a twentieth of the work of one card.
     2. Each card builds the stars of its part, a span of the curve.
     3. Each writes the simplices of its part over its own link to the host.
     4. The cards exchange the numbers of simplices across the borders of their parts (>>cells).

   A card holds all points, and its part of everything else: 90 + 560 / cards bytes a point (2D: 75 + 155 / cards).
   So two cards of one kind take 1.7 times the points of one, and many cards take points up to the limit of the
   simplex numbers (600 million).  If one card leaves a star to the CPU, the CPU takes the whole input.

   Devices that can reach each other open their pools to each other, and never close them again.  If a pool keeps
   60 GB, the first call takes half a second longer for that.

   POINTS THAT MOVE.  A loop has a pool of its own, which keeps what one step frees for the next.  It also keeps the
   mesh of the last step.
     1. A step puts the points into order.
     2. If the duplicates are the same, it tests the last mesh with the new coordinates (>>check): positive simplices,
        locally regular facets under the tie rule, a convex hull that is covered once, hidden points in conflict with
        no simplex.
     3. A mesh that passes is the triangulation of the new points.  Only the order of its simplices changes, as the
        ranks of their corners do (>>keep).
     4. If there is none that passes, the stars are built.

   CELLS.  The bytes are those of pbw_cells.h, as each sum has the same terms in the same order.  Cells that the box
   does not cut are sums over simplices (>>centres); each of the others is cut by a warp (>>polytopes, >>diagram).

   HOST MEMORY.  Pinned memory, as of cudaMallocHost, is copied at the speed of the link.  Other memory goes through
   16 pinned pieces of 1 MB for each device, which threads of the host fill and empty (>>staging).  New pages cost
   more than that: the host commits those of the results while the device works.  options.resize may hand out pinned
   blocks, but should keep them: to pin 100 MB takes 50 ms.

   MEMORY.  Device memory comes from the pool of the current device, at most options.memory_limit bytes of it.  If
   that is too little, which is known before the stars and before the output, the message says the bytes needed and
   available, and under PBW_BACKEND_OR_CPU the CPU takes over.

   CONTENTS
     >>device    types, tiles of lanes
     >>call      what one call holds: status, memory, streams, launches, the cards of a job
     >>staging   copies to and from memory of the host that is not pinned
     >>curve     points in the order of the Hilbert curve, duplicates set aside
     >>tree      groups of 8 points, boxes of 32 boxes
     >>sphere    the float form of a conflict test and its bound; the exact test
     >>star      one star: insertion, storing
     >>near      the first rung
     >>far       the second and third rung
     >>wide      the rungs for points on surfaces
     >>stars     all stars of a card: its part of the points, memory, the choice of rungs
     >>cards     copies between the cards of a job
     >>cells     simplices, neighbours, incident simplices
     >>check     the exact verdict on a mesh
     >>keep      a mesh whose points have moved, put into the order of the curve again
     >>centres   cells: centres of simplices, what simplices add to the cells of their corners
     >>polytopes cells: a polytope cut by planes
     >>diagram   cells: the star of a vertex, and its cell
     >>polygons  cells in the plane
     >>run       the stages in order
     >>backend   a job of pbw.h on one card or several
     >>local     points on the device: triangulate, free, check
     >>loop      points that move
     >>dual      the calls for cells
     >>transfer  cells of points in the memory of the host, on one card or several
     >>periods   cells of points in a periodic box
*/
#include <cuda_runtime.h>

#define PBW_STATIC
#define PBW_NO_SIMD
#define PBW_IMPLEMENTATION
#define PBW__DEVICE __host__ __device__
#define PBW_CHECK_IMPLEMENTATION
#include "pbw_check.h"

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

#define DEVICE __device__ __forceinline__            /* a function of kernels: its arguments stay in registers */
#define DEVICE_CALL __device__ __noinline__          /* one that is seldom called */
#define HOST_DEVICE __host__ __device__ inline

#ifndef PBW_CUDA_FEW
#define PBW_CUDA_FEW 1024                            /* fewer points are quicker on the CPU */
#endif
#ifdef PBW_CUDA_TEST
extern "C" {                                         /* tests set these */
#else
namespace {
#endif
int pbw_cuda_by_host = 0;                            /* copies between devices go by way of the host */
int pbw_cuda_patient = 0;                            /* no input is declined after a sample */
size_t pbw_cuda_piece = (size_t)1 << 20;             /* bytes of a piece of pinned memory */
long pbw_cuda_fail_at = 0;                           /* counts down: the allocation of device memory that fails */
}

namespace {

/* ------------------------------------------------------------------------------------------------------
   >>device       Types, tiles of lanes.
   Holds: every collective is executed by all lanes of a warp.

   A tile is 8 or 32 neighbouring lanes of a warp that work on one star.  The tiles of a warp run in lockstep: tiles
   with nothing to do (`go` is false there) pass through each collective.  Masks of less than a warp are legal, but
   tiles then drift apart, and the instruction cache thrashes.
   ------------------------------------------------------------------------------------------------------ */
const unsigned all_lanes = 0xffffffffu;
const uint32_t none = 0xffffffffu;                   /* no point; as a vertex of a star: the vertex at infinity */
const uint32_t hidden = 0xfffffffeu;                 /* as the place of a star: the vertex has none */

struct alignas(32) record {                          /* as pbw.h keeps them: {x, y, w, 0} or {x, y, z, w} */
    double c[4];
};

/* The box of 8 points or 32 boxes, in units of the space, rounded outward; weight: their largest less the
   heaviest. */
struct alignas(16) box {
    float low[3], high[3], weight, unused;
};

/* Grows a box to hold another. */
DEVICE void add_box(box &b, const box &other)
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
    const float4 *rough;                             /* the coordinates in units, rounded to floats */
    uint32_t count;
    double low[3], end[3], unit, heaviest;           /* end: the other corner of the box of all points */
    float high[3];                                   /* end in units, relative to low */
    pbw__grid grid;
    double exact_height;                             /* for lifts below it doubles are exact; 0 if nowhere */
};

struct queue {                                       /* vertices for the next rung, in no order */
    uint32_t *vertex, *count;                        /* the counts of all queues are neighbours in memory */
};

const uint32_t stored_mark = 1u << 31;               /* in a queue: the store holds a star to go on from */

/* The numbers first, ..., end - 1.  The part of a card: the ranks of its vertices. */
struct range {
    uint32_t first, end;
    __host__ __device__ uint32_t size() const { return end - first; }
    __device__ bool has(uint32_t v) const { return v >= first && v < end; }
};

/* The finished stars of a part.  A star is a head (triangles << 16 | vertices), its vertices, and its triangles: 3
   numbers of vertices in 10 bits each (2D: edges, 2 numbers), bit 30: verified; padded to 16 bytes. */
struct store : range {
    uint32_t *word;
    unsigned long long *used;                        /* units of 16 bytes needed: above capacity if it is too small */
    unsigned long long capacity;
    uint32_t *place;                                 /* for each vertex from first: the unit where its star begins */
    uint32_t *owned;                                 /* and how many simplices have it as their lowest vertex */
    const volatile uint32_t *stop;                   /* not 0: the call has failed or is cancelled, nothing counts */
};

/* Groups near another one.  A list covers the box of its group, grown by reach on all sides.  Its first close entries
   cover the balls of radius start, of about 33 points each, around the points of the group. */
struct near_list {
    uint32_t length;                                 /* 0: none, the stars of the group go to the second rung */
    float reach, start;
    uint32_t close;
};

/* The stars of a card's part while the rungs build them. */
struct star_build {
    space all;
    tree boxes;
    uint32_t *lists;                                 /* of groups near each group of the part */
    near_list *infos;
    store out;
    queue q[3];                                      /* stars for the next rung, in turn; q[2]: large stars */
    unsigned long long *seed;                        /* then a word: the search steps of a sample */
    uint32_t *next;                                  /* the first star that no warp has taken */
};

template <int T> DEVICE unsigned tile_ballot(bool value)
{
    unsigned vote = __ballot_sync(all_lanes, value);
    return T == 32 ? vote : vote >> (threadIdx.x & 31 & ~(T - 1)) & ((1u << (T & 31)) - 1);
}

template <int T> DEVICE unsigned lanes_below()
{
    return (1u << (threadIdx.x & (T - 1))) - 1;
}

/* Returns the index in a list at which each lane that takes part appends; length: of the list, which grows. */
template <int T> DEVICE int append(bool takes_part, int &length)
{
    const unsigned vote = tile_ballot<T>(takes_part);
    const int at = length + __popc(vote & lanes_below<T>());
    length += __popc(vote);
    return at;
}

/* Reads a value, of whole words, from another lane. */
template <int T, typename V> DEVICE V tile_read(V value, int lane)
{
    const int words = (int)(sizeof(V) / sizeof(uint32_t));
    uint32_t word[words];
    memcpy(word, &value, sizeof value);
    for (int i = 0; i < words; i++) {
        word[i] = __shfl_sync(all_lanes, word[i], lane, T);
    }
    memcpy(&value, word, sizeof value);
    return value;
}

template <typename V> DEVICE void exchange(V &a, V &b)
{
    const V c = a;
    a = b;
    b = c;
}

/* Reduces the values of the lanes that differ in the bits FROM, ..., TO / 2 of their numbers, two at a time. */
template <int FROM, int TO, typename V, typename F> DEVICE V combined(V value, F both)
{
    for (int step = TO / 2; step >= FROM; step /= 2) {
        value = both(value, __shfl_xor_sync(all_lanes, value, step));
    }
    return value;
}

template <int T, typename V> DEVICE V tile_min(V value)
{
    return combined<1, T>(value, [](V a, V b) { return min(a, b); });
}

template <int T, typename V> DEVICE V tile_max(V value)
{
    return combined<1, T>(value, [](V a, V b) { return max(a, b); });
}

template <int T, typename V> DEVICE V tile_sum(V value)
{
    return combined<1, T>(value, [](V a, V b) { return a + b; });
}

/* The largest value of any tile of the warp: where a loop of all tiles ends. */
template <int T> DEVICE int warp_max(int value)
{
    return combined<T, 32>(value, [](int a, int b) { return a > b ? a : b; });
}

DEVICE bool any(bool value)
{
    return __any_sync(all_lanes, value) != 0;
}

DEVICE size_t thread_number()
{
    return (size_t)blockIdx.x * blockDim.x + threadIdx.x;
}

/* Doubles as integers of the same order, for atomic minima and maxima. */
DEVICE unsigned long long ordered(double value)
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
   >>call         What one call holds: status, memory, streams, launches, the cards of a job.
   In: a job of pbw.h, or points on the device.  Out: functions by which all later rooms allocate, launch, sort, wait
   and fail.
   Holds: the blocks in the list of a call are all device memory that it has to free.

   All work is in the order of one stream; the host waits where it needs a count.  A stage that fails sets the status
   of its call, reports a message, and throws; so each stage may rely on all before it.  The entries catch, and free
   the memory of the call.

   A team of cards works on one job, each with a thread of the host, the whole tree and a part of the curve.  The
   cards wait for each other three times: to number the simplices, to fetch their halo simplices, and to fetch the
   simplices across them.  What a card offers to the others is complete when all have arrived, and stays until all
   leave.
   ------------------------------------------------------------------------------------------------------ */
/* Bytes of device memory at the peak, for uniform points, in 2D and 3D: of each point, and of each star of a part. */
const double bytes_a_point[2] = { 75.0, 90.0 }, bytes_a_star[2] = { 155.0, 560.0 };
const int most_cards = 16, mesh_arrays = 4;
const char *const few_points = "so few points are quicker on the CPU";
const char *const no_host_memory = "out of memory on the host";
const char *const too_many = "too many simplices for the index type";

struct offer {                                       /* what a card offers to the others */
    int device;
    range part;
    uint32_t simplices;
    void *halo[most_cards];                          /* the halo simplices of each higher card, their numbers */
    uint32_t *halo_numbers[most_cards], halo_count[most_cards];
    pbw_index *across, *incident;                    /* across: for its own halo, that of the lowest card first */
    bool open[most_cards];                           /* whether a card can read from this one */
};

struct card_team {
    std::mutex lock;
    std::condition_variable changed;
    int count, arrived = 0, departed = 0;
    unsigned generation = 0;
    std::atomic<int> status{ PBW_OK };               /* of the first card that failed */
    bool declined = false;
    offer offers[most_cards] = {};
};

/* What a call uses besides blocks of memory; all steps of a loop use those of the loop. */
struct call_resources {
    cudaMemPool_t pool;
    cudaStream_t copies;
    cudaEvent_t mark[8], ready[2];                   /* ready: of the end of work, for the host; for copies */
    char *pinned;                                    /* host memory for counts; NULL but in a loop */
};
const size_t pinned_bytes = 512;

struct host_copy {                                   /* between the device and the memory of the host */
    char *to;
    const char *from;
    size_t bytes;
    cudaEvent_t after;                               /* it begins after that */
};

/* What a loop keeps from step to step. */
struct loop_state {
    pbw_cuda_mesh mesh;
    uint32_t *id, count;                             /* of each rank; NULL if the CPU built the mesh */
};

struct call : call_resources {
    card_team *team;                                 /* of this job; one card for points on the device */
    pbw_cuda_mesh *mesh;                             /* what the call makes; of several cards each makes its part */
    loop_state *last;                                /* NULL: no step of a loop */
    bool borrowed, rebuild;                          /* borrowed: the resources; rebuild: without the last mesh */
    int card;
    cudaStream_t stream;
    pbw_job *job;                                    /* without reserve, keep: results stay on the device */
    size_t used, count, stars;                       /* bytes; points; stars of the part */
    uint32_t *stop;                                  /* on the device: kernels of stars end early if it is not 0 */
    bool stopped;
    int dim;
    pbw_status status;
    bool declined, no_cpu;                           /* no_cpu: the call may not leave it to the CPU */
    struct { void *address; size_t bytes; } block[40 + 3 * most_cards];
    int blocks;
    host_copy later[mesh_arrays];                    /* results to copy when all kernels are on their way */
    int laters;
};

/* Reports the first failure of any card; then all stop.  text: the message, or NULL. */
void report_failure(call &c, const char *text)
{
    std::lock_guard<std::mutex> hold(c.team->lock);
    if (c.team->status == PBW_OK && c.status != PBW_OK) {
        c.team->status = c.status;
        c.team->declined = c.declined;
        if (text != NULL) {
            c.job->say(c.job, text);
        }
        c.team->changed.notify_all();
    }
}

/* Sets the status of a call that has not failed yet, and reports the message. */
void fail(call &c, pbw_status status, const char *format, ...)
{
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (c.status == PBW_OK) {
        c.status = status;
        report_failure(c, text);
    }
}

struct failure {};                                   /* thrown: the status of the call is no longer PBW_OK */

void throw_if_failed(const call &c)
{
    if (c.status != PBW_OK) {
        throw failure();
    }
}

/* Fails unless a condition holds. */
template <typename... A> void require(call &c, bool holds, pbw_status status, const char *format, A... arguments)
{
    if (!holds) {
        fail(c, status, format, arguments...);
        throw failure();
    }
}

/* Declines the input, which the CPU may then take over, unless a condition holds that only the device needs. */
template <typename... A> void decline_unless(call &c, bool holds, const char *format, A... arguments)
{
    c.declined = c.declined || !holds;
    require(c, holds, PBW_ERROR_BACKEND, format, arguments...);
}

/* Declines the input if the last rung failed more than limit stars. */
void decline_above(call &c, uint32_t left, uint32_t limit)
{
    decline_unless(c, left <= limit, "%u stars are too large for the device (cospherical points?)", left);
}

/* Fails if the device reports an error; returns whether the call has not failed. */
bool good(call &c, cudaError_t error, const char *what)
{
    if (error != cudaSuccess) {
        fail(c, PBW_ERROR_BACKEND, "%s: %s", what, cudaGetErrorString(error));
    }
    return c.status == PBW_OK;
}

void need(call &c, cudaError_t error, const char *what)
{
    good(c, error, what);
    throw_if_failed(c);
}

/* Fails unless more bytes fit into free memory and the pool; the message has the need of the whole call, as far as it
   is known. */
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

void add_block(call &c, void *block, size_t bytes)
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
    cudaError_t error = fails ? cudaErrorMemoryAllocation : cudaMallocFromPoolAsync(&block, bytes, c.pool, c.stream);
    if (error == cudaErrorMemoryAllocation) {
        (void)cudaGetLastError();
        need_memory(c, bytes);
    }
    need(c, error, "cudaMallocAsync");
    add_block(c, block, bytes);
    return (V *)block;
}

/* Frees a block, or with keep only removes it from the list. */
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

/* Reports progress on the caller's thread; if the call is cancelled or another card has failed, so has this one. */
void poll(call &c, pbw_stage stage, double done)
{
    if (c.card == 0 && c.status == PBW_OK && c.job->report(c.job, stage, done) != 0) {
        c.status = PBW_CANCELLED;
        report_failure(c, NULL);
    }
    if (c.status == PBW_OK && c.team->status != PBW_OK) {
        c.status = (pbw_status)c.team->status.load();
    }
}

/* Waits for a stream and reports progress meanwhile.  If the call is cancelled or another card has failed, sets the
   stop word of the kernels through the stream of copies. */
void wait_for_stream(call &c, cudaStream_t stream, pbw_stage stage, double done)
{
    static const uint32_t one = 1;
    cudaError_t error = cudaEventRecord(c.ready[0], stream);
    while (error == cudaSuccess && (error = cudaEventQuery(c.ready[0])) == cudaErrorNotReady) {
        poll(c, stage, done);
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
    wait_for_stream(c, c.stream, stage, done);
    throw_if_failed(c);
}

/* A barrier: waits for the other cards until all arrive or one fails; with leaving until all leave, failed or not. */
void wait_for_cards(call &c, bool leaving, double done)
{
    card_team &t = *c.team;
    std::unique_lock<std::mutex> hold(t.lock);
    unsigned generation = t.generation;
    t.departed += leaving;
    t.arrived += !leaving;
    if (t.arrived == t.count) {
        t.arrived = 0;
        t.generation++;
    }
    t.changed.notify_all();
    while (leaving ? t.departed < t.count : t.generation == generation && t.status == PBW_OK) {
        t.changed.wait_for(hold, std::chrono::milliseconds(20));
        hold.unlock();
        poll(c, PBW_STAGE_OUTPUT, done);
        hold.lock();
    }
    hold.unlock();
    poll(c, PBW_STAGE_OUTPUT, done);
    if (!leaving) {
        throw_if_failed(c);
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
    wait(c, stage, done);
    return *to;
}

template <typename V> void fill(call &c, V *address, int byte, size_t count)
{
    need(c, cudaMemsetAsync(address, byte, count * sizeof(V), c.stream), "cudaMemsetAsync");
}

void record_mark(call &c, int mark)
{
    need(c, cudaEventRecord(c.mark[mark], c.stream), "cudaEventRecord");
}

/* Makes all later work of the stream of copies wait for the work that the call's stream has now. */
void copies_follow(call &c)
{
    need(c, cudaEventRecord(c.ready[1], c.stream), "cudaEventRecord");
    need(c, cudaStreamWaitEvent(c.copies, c.ready[1], 0), "cudaStreamWaitEvent");
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

/* Calls a function of CUB twice: for the size of the scratch memory that it needs, then to do its work. */
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

int processors_of(call &c, int device)
{
    int processors = 1;
    need(c, cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device), "cudaDeviceGetAttribute");
    return processors;
}

pbw_index *&array_of(pbw_cuda_mesh &mesh, int i)
{
    return i == 0 ? mesh.simplices : i == 1 ? mesh.neighbors : i == 2 ? mesh.incident : mesh.canonical;
}

size_t entries_of(const pbw_cuda_mesh &mesh, int i)
{
    return i < 2 ? mesh.simplex_count * (size_t)(mesh.dim + 1) : mesh.point_count;
}

/* Removes the arrays of a mesh from the blocks of the call: with keep they live on, else they are freed. */
void release_mesh(call &c, pbw_cuda_mesh mesh, bool keep)
{
    for (int i = 0; i < mesh_arrays; i++) {
        release(c, array_of(mesh, i), keep);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>staging      Copies to and from memory of the host that is not pinned.
   In: arrays on the device or in such memory.  Out: the same bytes on the other side.
   Holds: the pinned pieces of a device belong to one call at a time, and last as long as the process.

   The driver copies such memory by one thread: the results of a million points in space take as long as their stars.
   Here several threads of the host do, each with two pinned pieces: the copy engine moves one while the thread copies
   the other.  Results are copied when the device has all its work, and finds neighbours while simplices are copied.
   One thread is left to the driver, which is quicker then.
   ------------------------------------------------------------------------------------------------------ */
const int most_stagers = 8;                          /* threads: 216 MB take 9.0 ms by 4, 6.6 by 8, 5.9 by 16 */

struct staging {
    std::mutex busy;
    char *pinned;                                    /* two pieces for each thread; NULL before the first use */
    cudaStream_t stream[2 * most_stagers];           /* of each piece */
};

/* Returns the pieces of a device, which the caller then has until it unlocks them; NULL if another has them. */
staging *take_staging(int device)
{
    static staging all[most_cards];
    staging *const s = device < most_cards && all[device].busy.try_lock() ? &all[device] : NULL;
    const size_t bytes = 2 * most_stagers * pbw_cuda_piece;
    bool good = s != NULL && (s->pinned != NULL || cudaMallocHost(&s->pinned, bytes) == cudaSuccess);
    for (int i = 0; good && i < 2 * most_stagers; i++) {
        good = s->stream[i] != NULL
            || cudaStreamCreateWithFlags(&s->stream[i], cudaStreamNonBlocking) == cudaSuccess;
    }
    if (s != NULL && !good) {
        (void)cudaGetLastError();
        s->busy.unlock();
    }
    return good ? s : NULL;
}

/* Copies between a device and the host: those to do, and what the threads that do them share. */
struct staged_copies {
    const host_copy *copies;
    int count, device;
    bool to_host;
    staging *area = NULL;
    std::atomic<size_t> next{ 0 };                   /* the first piece that no thread has taken */
    std::atomic<bool> ends{ false };                 /* after an error, or when the caller wants it */
    std::atomic<int> error{ cudaSuccess };
};

size_t pieces_of(const host_copy &c)
{
    return (c.bytes + pbw_cuda_piece - 1) / pbw_cuda_piece;
}

/* Returns a piece of a copy, or one without bytes if all are taken. */
host_copy take_piece(staged_copies &s)
{
    size_t piece = s.next++;
    for (int i = 0; i < s.count && !s.ends; piece -= pieces_of(s.copies[i]), i++) {
        const host_copy &c = s.copies[i];
        if (piece < pieces_of(c)) {
            const size_t at = piece * pbw_cuda_piece;
            return { c.to + at, c.from + at, std::min(pbw_cuda_piece, c.bytes - at), c.after };
        }
    }
    return {};
}

/* Sends a piece on its way, to or from pinned memory. */
cudaError_t send_piece(const host_copy &c, char *pinned, bool to_host, cudaStream_t stream)
{
    const cudaError_t error = c.after != NULL ? cudaStreamWaitEvent(stream, c.after, 0) : cudaSuccess;
    if (error != cudaSuccess) {
        return error;
    }
    if (to_host) {
        return cudaMemcpyAsync(pinned, c.from, c.bytes, cudaMemcpyDeviceToHost, stream);
    }
    memcpy(pinned, c.from, c.bytes);
    return cudaMemcpyAsync(c.to, pinned, c.bytes, cudaMemcpyHostToDevice, stream);
}

/* What one of the threads does.  Calls poll between pieces; that returns whether to go on. */
template <typename F> void copy_pieces(staged_copies &s, int thread, F poll)
{
    host_copy sent[2] = {};
    cudaError_t error = cudaSetDevice(s.device);
    for (int i = 0, idle = 0; idle < 2; i = 1 - i) {
        char *const pinned = s.area->pinned + (size_t)(2 * thread + i) * pbw_cuda_piece;
        const cudaStream_t stream = s.area->stream[2 * thread + i];
        const cudaError_t arrived = cudaStreamSynchronize(stream);
        error = error == cudaSuccess ? arrived : error;
        if (s.to_host && sent[i].bytes > 0 && error == cudaSuccess) {
            memcpy(sent[i].to, pinned, sent[i].bytes);
        }
        sent[i] = error == cudaSuccess && poll() ? take_piece(s) : host_copy();
        if (sent[i].bytes > 0) {
            error = send_piece(sent[i], pinned, s.to_host, stream);
        }
        idle = sent[i].bytes > 0 ? 0 : idle + 1;
    }
    if (error != cudaSuccess) {
        s.error = error;
        s.ends = true;
    }
}

/* Copies by at most `threads` threads, the caller's among them, which calls poll meanwhile.  Returns false, and has
   done nothing, if there are few bytes or one thread, or another call has the pieces. */
template <typename F> bool copy_staged(staged_copies &s, int threads, F poll)
{
    size_t bytes = 0;
    for (int i = 0; i < s.count; i++) {
        bytes += s.copies[i].bytes;
    }
    threads = (int)std::min((size_t)std::min(threads, most_stagers), bytes / pbw_cuda_piece);
    s.area = threads > 1 ? take_staging(s.device) : NULL;
    if (s.area == NULL) {
        return false;
    }
    std::thread helper[most_stagers];
    try {
        for (int i = 1; i < threads; i++) {
            helper[i] = std::thread([&s, i] { copy_pieces(s, i, [] { return true; }); });
        }
    } catch (...) {                                  /* those that have started copy all */
    }
    copy_pieces(s, 0, [&] {
        const bool goes_on = poll();
        s.ends = s.ends || !goes_on;
        return goes_on;
    });
    for (std::thread &other : helper) {
        if (other.joinable()) {
            other.join();
        }
    }
    s.area->busy.unlock();
    return true;
}

bool is_pinned(const void *host)
{
    cudaPointerAttributes a = {};
    return cudaPointerGetAttributes(&a, host) == cudaSuccess && a.type != cudaMemoryTypeUnregistered;
}

/* copy_staged by the threads of a call, which may be cancelled meanwhile. */
bool copy_staged(call &c, const host_copy *copies, int count, bool to_host, pbw_stage stage)
{
    staged_copies s = { copies, count, c.team->offers[c.card].device, to_host };
    const bool staged = copy_staged(s, pbw__thread_count(c.job->threads, c.count) / c.team->count, [&] {
        poll(c, stage, to_host ? 0.4 : 0.0);
        return c.status == PBW_OK;
    });
    need(c, (cudaError_t)s.error.load(), "copying");
    return staged;
}

/* ------------------------------------------------------------------------------------------------------
   >>curve        Points in the order of the Hilbert curve, duplicates set aside.
   In: packed points and weights.  Out: records by rank, the caller's id of each rank, for each point the one that it
   duplicates, and the ranges of coordinates and weights; all as >>order of pbw.h has them, from equal keys.

   1. All points are sorted by their keys on the curve.
   2. Short runs of equal keys go into lexicographic order.
   3. The points of a long run get keys from a grid over their own box.  The long runs of one depth are ordered
      together: their points are gathered, sorted by the new key, then by their run, and put back.
   4. Steps 2 and 3 again for the runs of equal keys that remain.
   ------------------------------------------------------------------------------------------------------ */
struct input {
    const void *points, *weights;
    size_t count;
    int dim, is_float;
};

struct survey {                                      /* of one pass over the points */
    unsigned long long low[4], high[4];              /* the range of x, y, z and the weight, ordered */
    int unit;                                        /* the exponent of the common grid, see pbw__grid_share */
    uint32_t bad, long_runs, duplicates;
};

DEVICE void fetch(const input &in, size_t i, double *c)
{
    auto number = [&](const void *of, size_t at) {
        return (in.is_float ? (double)((const float *)of)[at] : ((const double *)of)[at]) + 0.0;
    };
    for (int k = 0; k < in.dim; k++) {
        c[k] = number(in.points, i * (size_t)in.dim + (size_t)k);
    }
    c[in.dim] = in.weights != NULL ? number(in.weights, i) : 0.0;
}

/* Points and their keys: of all points, or of those of long runs. */
struct keyed {
    input in;
    int index_bits, bits;                            /* of the index, in the low bits of a key; of a coordinate */
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

__global__ void survey_kernel(input in, survey *out)
{
    pbw__grid_share found;
    bool bad = false;
    pbw__grid_share_reset(&found);
    for (size_t i = thread_number(); i < in.count; i += (size_t)gridDim.x * blockDim.x) {
        double c[4];
        fetch(in, i, c);
        for (int k = 0; k <= in.dim; k++) {
            int64_t mantissa;
            int exponent = pbw__decode(c[k], &mantissa);
            exponent = mantissa != 0 ? exponent + __ffsll((long long)mantissa) - 1 : 1024;   /* of the lowest bit */
            bad = bad || !(c[k] - c[k] == 0.0);
            found.low[k] = fmin(found.low[k], c[k]);
            found.high[k] = fmax(found.high[k], c[k]);
            found.unit = min(found.unit, k < in.dim || mantissa == 0 ? exponent : (exponent - (exponent & 1)) / 2);
        }
    }
    bad = any(bad);
    found.unit = tile_min<32>(found.unit);
    for (int k = 0; k <= in.dim; k++) {
        const double low = tile_min<32>(found.low[k]), high = tile_max<32>(found.high[k]);
        if ((threadIdx.x & 31) == 0) {
            atomicMin(&out->low[k], ordered(low));
            atomicMax(&out->high[k], ordered(high));
        }
    }
    if ((threadIdx.x & 31) == 0) {
        atomicMin(&out->unit, found.unit);
        atomicOr(&out->bad, (uint32_t)bad);
    }
}

__global__ void key_kernel(const __grid_constant__ keyed k, const __grid_constant__ pbw__box domain)
{
    size_t i = thread_number();
    if (i < k.in.count) {
        k.key[i] = k.key_of(i, domain);
    }
}

/* Long runs: their places among all keys, and where they begin among the gathered ones. */
struct run_list {
    range *place;
    uint32_t *offset;
};

/* Finds runs among count keys: all keys or, with segment, keys gathered from the runs of a list; then segment[i] is
   the number of the run that key i is from.  The thread of the first key of a short run puts it into order:
   lexicographic, then the larger weight, then the lower index.  Long runs go to found, with an upper bound of their
   ends. */
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
        limit = begin + of.place[r].size();
        shift = of.place[r].first - begin;
    }
    if (i > begin && k.tie(i - 1, i)) {
        return;
    }
    while (end < limit && end - i <= PBW__SHORT_RUN && k.tie(end, i)) {
        end++;
    }
    if (end - i > PBW__SHORT_RUN) {
        found.place[atomicAdd(&out->long_runs, 1u)] = { (uint32_t)(i + shift), (uint32_t)(limit + shift) };
        return;
    }
    for (size_t j = i + 1; j < end; j++) {
        for (size_t hole = j; hole > i && k.before(hole, hole - 1); hole--) {
            exchange(k.key[hole], k.key[hole - 1]);
        }
    }
}

/* A warp measures each run: its end, length and box.  If all its points coincide the length is 0, the one that stays
   goes first, and root has its index for all of them. */
__global__ void measure_kernel(const __grid_constant__ keyed k, run_list runs, uint32_t count, pbw__box *boxes,
                               uint32_t *root)
{
    const uint32_t r = blockIdx.x * (blockDim.x / 32) + threadIdx.x / 32, lane = threadIdx.x & 31;
    pbw__box box;
    if (r >= count) {
        return;
    }
    uint32_t head = runs.place[r].first, end = head, limit = runs.place[r].end, best = head;
    pbw__box_reset(&box, k.bits);
    for (unsigned vote = all_lanes; vote == all_lanes; end += (uint32_t)__popc(vote)) {
        uint32_t i = end + lane;
        bool inside = i < limit && k.tie(i, head);
        vote = __ballot_sync(all_lanes, inside);
        if (inside) {
            double c[4];
            k.read(i, c);
            pbw__box_add(&box, c, k.in.dim);
            best = k.before(i, best) ? i : best;
        }
    }
    best = combined<1, 32>(best, [&](uint32_t a, uint32_t b) { return k.before(b, a) ? b : a; });
    for (int j = 0; j < k.in.dim; j++) {
        box.low[j] = tile_min<32>(box.low[j]);
        box.high[j] = tile_max<32>(box.high[j]);
    }
    pbw__box_close(&box, k.in.dim);
    const bool apart = box.extent > 0.0;
    __syncwarp();
    if (lane == 0) {
        boxes[r] = box;
        runs.place[r].end = apart ? end : head;
        runs.offset[r] = apart ? end - head : 0;     /* the length, until lengths are summed */
        if (!apart) {
            exchange(k.key[head], k.key[best]);
        }
    }
    for (uint32_t i = head + lane; !apart && i < end; i += 32) {
        root[i] = head;
    }
}

/* Gathers the points of a run by each warp, with their new keys. */
__global__ void rekey_kernel(const __grid_constant__ keyed k, run_list runs, uint32_t count, const pbw__box *box,
                             uint64_t *gathered, uint32_t *segment)
{
    uint32_t r = blockIdx.x * (blockDim.x / 32) + threadIdx.x / 32;
    for (uint32_t i = threadIdx.x & 31; r < count && i < runs.place[r].size(); i += 32) {
        gathered[runs.offset[r] + i] = k.key_of(k.index(runs.place[r].first + i), box[r]);
        segment[runs.offset[r] + i] = r;
    }
}

__global__ void put_back_kernel(const uint64_t *gathered, const uint32_t *segment, size_t count, run_list runs,
                                uint64_t *key)
{
    size_t i = thread_number();
    if (i < count) {
        uint32_t r = segment[i];
        key[runs.place[r].first + (i - runs.offset[r])] = gathered[i];
    }
}

/* first[i] = 1 if the i-th point on the curve is the one that stays of those that coincide with it.  root_of: NULL,
   or for each point of a long run of points that coincide where the run begins, else none. */
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
        record r = {};
        k.read(i, r.c);
        point[at] = r;
        id[at] = (uint32_t)k.index(i);
    }
}

struct run_buffers {
    buffer<range> place;
    buffer<uint32_t> offset;                         /* with the sum of all lengths behind */
    explicit run_buffers(call &c) : place(c), offset(c) {}
    run_buffers(call &c, size_t count) : place(c, count), offset(c, count + 1) {}
    run_list list() const { return { place.at, offset.at }; }
};

/* Points that are put into the order of the curve. */
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

/* Gives the points of count long runs keys from a grid for each run, and puts them back in their order.  Returns the
   long runs of equal keys that are left, and sets count to their number. */
run_buffers order_long_runs(call &c, ordering &o, const run_list &runs, uint32_t &count)
{
    const shape warps = over((size_t)count * 32, 128);
    const uint32_t runs_here = count;
    buffer<pbw__box> box(c, count);
    run_buffers next(c);
    fill(c, runs.offset + count, 0, 1);
    launch(c, "runs", measure_kernel, warps, o.all, runs, count, box.at, o.root.at);
    sum_before(c, runs.offset, runs.offset, (size_t)count + 1);
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
        next = run_buffers(c, total / PBW__SHORT_RUN + 1);
        fill(c, &o.found.at->long_runs, 0, 1);
        launch(c, "runs", run_kernel, over(total, 256), some, total, segment.array.at, runs, next.list(), o.found.at);
        launch(c, "runs", put_back_kernel, over(total, 256), some.key, segment.array.at, total, runs, o.all.key);
        count = read_back(c, &o.found.at->long_runs, PBW_STAGE_ORDER, 0.4);
    }
    return next;
}

/* Puts the runs of equal keys into order.  As in >>order of pbw.h each level divides the extent by 2^bits. */
void order_runs(call &c, ordering &o)
{
    const size_t n = o.all.in.count;
    run_buffers runs(c, n / PBW__SHORT_RUN + 1);
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

/* Returns the ranges of coordinates and weights, and the unit of their common grid; later kernels use on_device. */
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
    decline_unless(c, domain.extent > 1e-100 && domain.extent < 1e100,
                   "the extent of the points is beyond the range of the device code");
    (void)frexp(domain.extent, &exponent);
    s.unit = ldexp(1.0, 1 - exponent);
    decline_unless(c, weight_range * (s.unit * s.unit) < 1e12, "the weights are beyond the range of the device code");
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
void gather_points(call &c, const ordering &o, space &s, uint32_t *&id)
{
    const size_t n = o.all.in.count;
    buffer<uint32_t> first(c, n), rank(c);
    launch(c, "places", place_kernel, over(n, 256), o.all, o.root.at, first.at, c.mesh->canonical, o.found.at);
    c.mesh->duplicate_count = read_back(c, &o.found.at->duplicates, PBW_STAGE_ORDER, 0.5);
    s.count = (uint32_t)(n - c.mesh->duplicate_count);
    decline_unless(c, s.count >= PBW_CUDA_FEW, few_points);
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
bool order_points(call &c, const input &in, space &s, uint32_t *&id)
{
    ordering o(c, in);
    const pbw__grid_share range = survey_points(c, in, o.found);
    const pbw__box domain = measure_space(c, range, o.all.bits, in.dim, s);
    sortable<cub::NullType> nothing(c);
    o.key = sortable<uint64_t>(c, in.count);
    o.all.key = o.key.array.at;
    launch(c, "keys", key_kernel, over(in.count, 256), o.all, domain);
    sort_pairs(c, o.key, nothing, in.count, o.sorted_bits());
    o.all.key = o.key.array.at;
    order_runs(c, o);
    gather_points(c, o, s, id);
    return in.weights != NULL && range.high[in.dim] > range.low[in.dim];
}

/* ------------------------------------------------------------------------------------------------------
   >>tree         Groups of 8 points, boxes of 32 boxes; for each group the list of groups near it.
   In: a space.  Out: a tree, and lists.  The children of a node are neighbours in memory, so that a warp tests all of
   them at once.
   ------------------------------------------------------------------------------------------------------ */
const int group_size = 8, list_size = 192;

DEVICE double in_units(const space &s, const record &r, int k)
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
DEVICE float side_near(const tree &t, int dim, uint32_t g)
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
DEVICE int list_within(const tree &t, const box &own, float reach, uint32_t *found, uint32_t *stack)
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
        const int at = append<32>(touches, level == 0 ? length : depth);
        if (touches && level > 0) {
            stack[at] = (uint32_t)level << 29 | node;
        } else if (touches && at < list_size) {
            found[at] = node;
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

/* Writes the groups found for group g, the nearest centre first: the place of a group is the number of nearer ones.
   Returns, in all lanes, the number of entries up to the last one that is closer than start. */
DEVICE uint32_t sort_list(const tree &t, uint32_t g, float start, uint32_t *found, int length, uint32_t *list)
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

/* A warp makes the list of a group.  The reach starts as a part of the side near it, and changes until it fits. */
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
        info[row] = { (uint32_t)length, reach, start, close };
    }
}

void build_tree(call &c, space &s, int dim, tree &t)
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

/* ------------------------------------------------------------------------------------------------------
   >>sphere       The float form of a conflict test and its bound; the exact test.
   In: a vertex v, points around it.  Out: the spheres of simplices, four floats each; whether a point is in conflict
   with a simplex: 1, 0, or open_sign.

   All places are relative to v and in units of the space: a = (a' - v') unit.  Let (v, a, b, c) be a simplex with
   D = a . (b x c) > 0 and lifts l_a = |a|^2 - (w_a - w_v) and so on.  The point p is in conflict if and only if

       l_p - q . p < 0,     q = N / D,     N = l_a (b x c) + l_b (c x a) + l_c (a x b):

   q is twice the centre of the (ortho)sphere.  For an infinite simplex on the facet (v, a, b) the test is -q . p < 0
   with q = 2^112 (a x b) / |a x b|: the lift, below 2^41, is negligible beside that.  In the plane D = a x b and
   N = l_a b' - l_b a', where a' is a turned by a right angle.

   A sphere is four floats: q, and Q, a size that carries the error of q; Q >= 2^112 marks an infinite simplex.  It is
   calculated in doubles or, as many cards are slow at those, in floats: then only the differences of coordinates are
   doubles, and rounded.

   Let f = 2^-24; g = 2^-53 for doubles, f for floats; A = |a|, L_a = |a|^2 + |w_a - w_v|, and so on for b, c and p.

     D    3 factors for differences, 5 for products and sums, terms at most 1.16 ABC (the permanent of a matrix with
          rows of norm 1 is at most 6/3^1.5):                                     error at most  10 g ABC
     N    lifts 6 factors, crosses 4, product and sums 3, terms at most sqrt 2 E,
          E = L_a BC + L_b AC + L_c AB:                                      error at most  19 g E
     q    doubles: if D > 2^-48 ABC > 20 g ABC the true D is at least half of it:     at most  40 g (E + |q| ABC) / D
          floats: if D > 2^-16 ABC the true D is at least 0.96 of it:                 at most  20 g (E + |q| ABC) / D
          and |q| 4 f more for the inverse, the product and rounding to float.
     test lift 6, p, q rounded to floats or so calculated; 4 sums:           error at most  10 f L_p + 9 f |q| P more
          (a float p is off by f P, that is f |q| P in q . p; each fused step rounds a sum of at most L_p + |q| P).

   Let Q = |q| + h (E + |q| ABC) / D, with h = 2^-27 for doubles and 21/16 > 20/16 for floats.

     1. The bound 2^-20 (L_p + Q P) = 16 f (L_p + |q| P) + 16 f h P (...) is above the sum of these errors, of those
        of roots (2^-22) and, for an infinite simplex, of the lift: 8 f Q P > 2^41.
     2. So the true q is within 2^-20 Q of q, the true centre within 2^-21 Q of q / 2, and the radius is at most
        |q| / 2 + 2^-21 Q.
     3. The sign is open if Q is infinite, which means that nothing is known of the sphere, and for P below 2^-50
        (floats: 2^-24), where squares (products of four lengths) might underflow.
     4. In the plane and for infinite simplices there are fewer factors: a x b is off by 6 g AB.  If its length is
        more than 2^-48 AB (floats: 2^-12 AB), its direction is off by 12 g AB / |a x b| <= 16 f h AB / |a x b|.

   A wall is an infinite simplex on a side of the box of all points: v, a and b have one extreme coordinate in common.
   No point is outside of it.  A point in its plane is in conflict with it exactly if it is in conflict with the
   finite simplex behind it, which is in the star too.  So the search leaves walls out; else each point of a flat side
   would be a candidate for each star there.  A wall has Q = -2^111: its q is exact, and no point passes the test.
   ------------------------------------------------------------------------------------------------------ */
const float slack = 9.5367431640625e-7f;             /* 2^-20 */
const float far_away = 5.192296858534828e33f;        /* 2^112 */
const int open_sign = PBW__OPEN;

template <typename REAL> struct place {              /* relative to v, in units */
    REAL x[3], w;
};

/* The constants that differ between doubles and floats: the least square that is large enough, the D / ABC and the
   (|a x b| / AB)^2 from which the bounds hold, and the factor of the error in Q. */
template <typename REAL> struct sizes {
    static const bool is_double = sizeof(REAL) == sizeof(double);
    static __device__ REAL least() { return (REAL)(is_double ? 7.9e-31 : 3.6e-15); }             /* 2^-100, 2^-48 */
    static __device__ REAL flat() { return (REAL)(is_double ? 3.5527136788005009e-15 : 1.52587890625e-5); }
    static __device__ REAL thin() { return (REAL)(is_double ? 1.3e-29 : 6e-8); }                 /* 2^-96, 2^-24 */
    static __device__ REAL error() { return (REAL)(is_double ? 7.4505805969238281e-9 : 1.3125); }
    static __device__ double inverse(double d) { return 1.0 / d; }
    static __device__ float inverse(float d) { return __fdividef(1.0f, d); }         /* relative error 2^-22 */
    static __device__ REAL scaled(double difference, double unit)
    {
        const REAL x = (REAL)(difference * unit);    /* never 0 if the difference is not: walls depend on it */
        return !is_double && x == 0 && difference != 0.0 ? (REAL)1e-37 : x;
    }
};

struct probe {                                       /* a place in floats, with the sizes of its errors */
    float x[3], lift, load, size;                    /* load: 2^-20 L_p; size: 2^-20 P, or infinity */
};

DEVICE float dot(const float *a, const float *b)
{
    return fmaf(a[0], b[0], fmaf(a[1], b[1], a[2] * b[2]));
}

DEVICE float root(float value)            /* relative error 2^-22 */
{
    float result;
    asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(value));
    return result;
}

template <int DIM, typename REAL> DEVICE place<REAL> relative(const space &s, const record &v, const record &p)
{
    place<REAL> r;
    for (int k = 0; k < 3; k++) {
        r.x[k] = k < DIM ? sizes<REAL>::scaled(p.c[k] - v.c[k], s.unit) : 0;
    }
    r.w = (REAL)((p.c[DIM] - v.c[DIM]) * (s.unit * s.unit));
    return r;
}

template <int DIM, typename REAL> DEVICE REAL square(const REAL *x)
{
    return DIM == 3 ? x[0] * x[0] + x[1] * x[1] + x[2] * x[2] : x[0] * x[0] + x[1] * x[1];
}

template <typename REAL> DEVICE REAL product(const REAL *a, const REAL *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <typename REAL> DEVICE void cross(const REAL *a, const REAL *b, REAL *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

template <int DIM, bool WEIGHTED, typename REAL> DEVICE probe probe_of(const place<REAL> &p)
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

DEVICE bool is_wall(float4 q)
{
    return q.w < 0.0f;
}

/* The walls through v, as bits: the lower and the upper side of each axis. */
template <int DIM> DEVICE unsigned walls_of(const space &s, const record &v)
{
    unsigned walls = 0;
    for (int k = 0; k < DIM; k++) {
        walls |= (v.c[k] == s.low[k] ? 1u : 0u) << (2 * k) | (v.c[k] == s.end[k] ? 2u : 0u) << (2 * k);
    }
    return walls;
}

/* 1: in conflict, 0: not, open_sign. */
DEVICE int side(float4 q, const probe &p)
{
    float s = fmaf(-q.x, p.x[0], fmaf(-q.y, p.x[1], fmaf(-q.z, p.x[2], p.lift)));
    float e = fmaf(fabsf(q.w), p.size, p.load);
    return s > e ? 0 : s < -e ? 1 : open_sign;
}

DEVICE float4 unknown_sphere()
{
    return make_float4(0.0f, 0.0f, 0.0f, HUGE_VALF);
}

template <typename REAL> DEVICE float4 sphere_of(const REAL *n, REAL d, REAL e, REAL product)
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
DEVICE float4 sphere(const place<REAL> &pa, const place<REAL> &pb, const place<REAL> &pc)
{
    const REAL *a = pa.x, *b = pb.x, *c = pc.x, least = sizes<REAL>::least();
    REAL la = square<DIM>(a), lb = square<DIM>(b), lc = DIM == 3 ? square<DIM>(c) : (REAL)1;
    REAL n[3] = { 0, 0, 0 }, bc[3], ca[3], ab[3];
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
    cross(b, c, bc);
    cross(c, a, ca);
    cross(a, b, ab);
    for (int k = 0; k < 3; k++) {
        n[k] = la * bc[k] + lb * ca[k] + lc * ab[k];
    }
    return sphere_of(n, product(a, bc), La * B * C + Lb * A * C + Lc * A * B, A * B * C);
}

/* The half-space beyond the facet (v, a, b); in the plane left of the line from v to a, for sign -1 right of it. */
template <int DIM, typename REAL>
DEVICE float4 half_space(const place<REAL> &pa, const place<REAL> &pb, REAL sign, unsigned walls)
{
    const REAL *a = pa.x, *b = pb.x, least = sizes<REAL>::least();
    REAL la = square<DIM>(a), lb = DIM == 3 ? square<DIM>(b) : (REAL)1, n[3] = { -a[1] * sign, a[0] * sign, 0 };
    if (DIM == 3) {
        cross(a, b, n);
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

/* A triangle: three local numbers of vertices, 0 being the vertex at infinity, and a mark if no point of the input is
   in conflict with its simplex: no insertion will remove it. */
const uint32_t corner_mask = 1023, verified = 1u << 30;

DEVICE uint32_t corner(uint32_t triangle, int k)
{
    return triangle >> (10 * k) & corner_mask;
}

template <int DIM> DEVICE uint3 corners(uint32_t triangle)
{
    return make_uint3(corner(triangle, 0), corner(triangle, 1), DIM == 3 ? corner(triangle, 2) : 0);
}

/* Returns the number of the triangle that has the directed edge (a, b), or -1.  In the plane: of the edge from a, or
   if a is none, of the edge to b. */
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

/* Returns the number of the triangle across from corner k of the packed one. */
template <int DIM> DEVICE int opposite_of(const uint32_t *triangle, int count, uint32_t packed, int k)
{
    return DIM == 3 ? triangle_with<DIM>(triangle, count, corner(packed, (k + 2) % 3), corner(packed, (k + 1) % 3))
         : k == 0 ? triangle_with<DIM>(triangle, count, corner(packed, 1), 0)
                  : triangle_with<DIM>(triangle, count, none, corner(packed, 0));
}

/* Where a star is built: round vertex v.  pool: for the last exact stage, or NULL. */
struct site {
    const space *all;
    uint32_t v;
    unsigned walls;
    pbw__digit *pool;
};

/* ------------------------------------------------------------------------------------------------------
   >>star         One star: a link of triangles (in the plane: edges), each counter-clockwise as seen from outside.
   In: points near a vertex, one by one.  Out: its star, packed, in the store.
   Holds between insertions: the link is closed; every simplex (v, triangle) is positively oriented, or is infinite
   and has corner 0; each triangle has the sphere of its simplex; the bit matrix is all zeros.
   ------------------------------------------------------------------------------------------------------ */

/* The numbers that a rung calculates with. */
template <bool EXACT> using rung_real = std::conditional_t<EXACT, double, float>;

/* NT triangles, NV vertices, SCRATCH words for the rung's search. */
template <int DIM, bool WEIGHTED, int NT, int NV, int SCRATCH, typename REAL> struct star {
    typedef REAL real;
    static const int dim = DIM, triangles = NT, vertices = NV, words = NV / 32, bits = NT > 256 ? 10 : 8;
    static const bool weighted = WEIGHTED;
    typedef std::conditional_t<(bits > 8), uint16_t, uint8_t> number;
    typedef std::conditional_t<(bits > 8), uint32_t, uint16_t> pair;         /* of numbers of vertices */
    typedef std::conditional_t<(bits > 8), uint64_t, uint32_t> set;
    float4 sphere[NT];
    REAL x[NV][DIM], w[WEIGHTED ? NV : 1];
    uint32_t id[NV], triangle[NT], matrix[NV * words], used[words], scratch[SCRATCH];
    pair border[NT + 4];
    number cavity[NT];
};

/* The place of a point of a star S. */
template <typename S> using place_in = place<typename S::real>;

/* A point that may become a vertex of a star S: its rank and, relative to v, its place. */
template <typename S> struct point_of {
    uint32_t id;
    place_in<S> p;
};

/* The candidate of this lane; if there is none, at the place of v. */
template <typename S> DEVICE point_of<S> candidate_at(const site &at, const record &own, uint32_t id)
{
    const record &r = at.all->point[id != none ? id : at.v];
    return { id, relative<S::dim, typename S::real>(*at.all, own, r) };
}

/* A larger star has a kernel of its own in >>cells. */
const int small_triangles = 60, small_vertices = 32;

enum { star_changed = 1, star_open = 2, star_full = 4, star_hidden = 8 };

DEVICE uint32_t pack(uint32_t a, uint32_t b, uint32_t c)
{
    return a | b << 10 | c << 20;
}

template <typename S> DEVICE void set_vertex(S &s, uint32_t number, uint32_t id, const place_in<S> &p)
{
    s.id[number] = id;
    for (int k = 0; k < S::dim; k++) {
        s.x[number][k] = p.x[k];
    }
    if (S::weighted) {
        s.w[number] = p.w;
    }
}

template <typename S> DEVICE place_in<S> vertex_place(const S &s, uint32_t number)
{
    place_in<S> p;
    for (int k = 0; k < 3; k++) {
        p.x[k] = k < S::dim ? s.x[number][k] : 0;
    }
    p.w = S::weighted ? s.w[number] : 0;
    return p;
}

/* The sphere of a triangle with corners at a, b and c, in 2D of an edge; corner 0 is the vertex at infinity. */
template <int DIM, bool WEIGHTED, typename REAL>
DEVICE float4 sphere_of_triangle(uint3 t, const place<REAL> &a, const place<REAL> &b, const place<REAL> &c,
                                            unsigned walls)
{
    if (t.x != 0 && t.y != 0 && (DIM == 2 || t.z != 0)) {
        return sphere<DIM, WEIGHTED>(a, b, c);
    }
    place<REAL> from, to;                            /* the finite edge or end, selected without pointers */
    for (int k = 0; k < 3; k++) {
        from.x[k] = t.x == 0 ? b.x[k] : DIM == 3 && t.y == 0 ? c.x[k] : a.x[k];
        to.x[k] = DIM == 2 ? from.x[k] : t.x == 0 ? c.x[k] : t.y == 0 ? a.x[k] : b.x[k];
    }
    return half_space<DIM>(from, to, (REAL)(DIM == 2 && t.x == 0 ? -1 : 1), walls);
}

template <typename S> DEVICE float4 sphere_in(const S &s, uint3 t, unsigned walls)
{
    return sphere_of_triangle<S::dim, S::weighted>(t, vertex_place(s, t.x), vertex_place(s, t.y),
                                                   vertex_place(s, t.z), walls);
}

/* Sets used to 0 and the vertices that triangles have. */
template <int T, typename S> DEVICE void find_used(S &s, bool go, int count)
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

/* The cavity of a point in a star: how many triangles are in conflict with it, how many edges its border has, and the
   number of the point. */
struct star_cavity {
    int conflicts, edges;
    uint32_t number;
};

/* Returns whether point p is in conflict with triangle t of a star, by exact tests.  For an infinite simplex with p
   in the plane of its facet the answer is that for the finite simplex behind the facet. */
template <typename S> __device__ __noinline__ int exact_conflict(const S &s, site at, int count, int t, uint32_t p)
{
    const space &all = *at.all;
    const double *row[4] = { all.point[at.v].c }, *origin = all.point[p].c;
    for (int round = 0; round < 2; round++) {
        int infinite = -1;
        for (int k = 0; k < S::dim; k++) {           /* p in place of the vertex at infinity */
            const uint32_t c = corner(s.triangle[t], k);
            infinite = c == 0 ? k : infinite;
            row[k + 1] = c == 0 ? origin : all.point[s.id[c]].c;
        }
        if (infinite < 0) {
            return pbw__conflict_in(at.pool, S::dim, row, origin, &all.grid);
        }
        const int sign = round == 0 ? pbw__orient_in(at.pool, S::dim, row, &all.grid) : PBW__OPEN;
        if (sign != 0) {
            return sign == PBW__OPEN ? open_sign : sign > 0;
        }
        t = opposite_of<S::dim>(s.triangle, count, s.triangle[t], infinite);
        if (t < 0) {
            return open_sign;
        }
    }
    return open_sign;
}

/* As exact_conflict, for p relative to v, by doubles that round nothing: on a small grid all products are integers in
   its unit, below 2^53 (>>cavity3 of pbw.h: there p is the origin, here v, but the 24 products have the same bound).
   The coefficients of the lifts are those of pbw__tie.  Returns open_sign if a height is beyond the limit of that. */
template <typename S>
__device__ __noinline__ int exact_conflict_on_grid(const S &s, int count, int t, double limit, place_in<S> point)
{
    const double p[3] = { point.x[0], point.x[1], point.x[2] };
    const double lift = square<S::dim>(p) - (S::weighted ? point.w : 0.0);
    if (!(square<S::dim>(p) + (S::weighted ? fabs(point.w) : 0.0) < limit)) {
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
            double u[3], q[3];
            cross(b, c, u);
            cross(p, a, q);
            d = product(a, u);
            k[0] = product(p, u);
            k[1] = -product(c, q);
            k[2] = product(b, q);
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
            t = opposite_of<S::dim>(s.triangle, count, packed, at);
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

/* Calculates the sphere of triangle t again, by doubles.  Returns the answer for point p. */
template <typename S> __device__ __noinline__ int refine(S &s, site at, int t, uint32_t p)
{
    const record *point = at.all->point, own = point[at.v];
    const uint3 c = corners<S::dim>(s.triangle[t]);
    auto place_of = [&](uint32_t id) { return relative<S::dim, double>(*at.all, own, point[id]); };
    auto corner_place = [&](uint32_t number) { return place_of(number != 0 ? s.id[number] : at.v); };
    float4 q = sphere_of_triangle<S::dim, S::weighted>(c, corner_place(c.x), corner_place(c.y), corner_place(c.z),
                                                       at.walls);
    s.sphere[t] = q;
    return side(q, probe_of<S::dim, S::weighted>(place_of(p)));
}

/* Decides a conflict that float spheres leave open: by exact tests if the star is in doubles, else by doubles. */
template <typename S> DEVICE int decide(S &s, const site &at, int count, int t, const point_of<S> &point)
{
    if (!std::is_same<typename S::real, double>::value) {
        return refine(s, at, t, point.id);
    }
    int hit = exact_conflict_on_grid(s, count, t, at.all->exact_height, point.p);
    return hit != open_sign ? hit : exact_conflict(s, at, count, t, point.id);
}

/* Lists the triangles in conflict with a point.  Returns star_open if a sign stays open, else 0. */
template <int T, bool DECIDES, typename S>
DEVICE int find_conflicts(S &s, const site &at, bool go, const point_of<S> &point, int count, star_cavity &cavity)
{
    const int lane = (int)threadIdx.x & (T - 1), rounds = (warp_max<T>(go ? count : 0) + T - 1) / T;
    const probe float_p = probe_of<S::dim, S::weighted>(point.p);
    typename S::set hits = 0, opens = 0;             /* bit i: triangle i T + lane */
    int result = 0;
#pragma unroll(S::triangles / T < 8 ? S::triangles / T : 1)
    for (int i = 0; i < S::triangles / T; i++) {
        if (i == rounds) {
            break;
        }
        int t = i * T + lane, hit = go && t < count ? side(s.sphere[t], float_p) : 0;
        hits |= (typename S::set)(hit == 1) << i;
        opens |= (typename S::set)(hit == open_sign) << i;
    }
    if (any(opens != 0)) {
        bool undecided = !DECIDES && opens != 0;
        for (int i = 0; DECIDES && i < rounds; i++) {
            if ((opens >> i & 1) != 0) {
                int hit = decide(s, at, count, i * T + lane, point);
                hits |= (typename S::set)(hit == 1) << i;
                undecided = undecided || hit == open_sign;
            }
        }
        result = tile_ballot<T>(undecided) != 0 ? star_open : 0;
    }
    cavity.conflicts = 0;
    for (int i = 0; i < rounds; i++) {
        const bool hit = (hits >> i & 1) != 0;
        const int to = append<T>(hit, cavity.conflicts);
        if (hit) {
            s.cavity[to] = (typename S::number)(i * T + lane);
        }
    }
    return result;
}

/* An edge (a, b) as a bit of the matrix of a star: column b of row a.  In the plane the two ends of an edge have a
   bit each: row 0 is for vertices where an edge begins, row 1 for those where one ends. */
struct matrix_bit {
    uint32_t row, column;
    template <typename S> __device__ uint32_t &word(S &s) const { return s.matrix[row * S::words + (column >> 5)]; }
    __device__ uint32_t bit() const { return 1u << (column & 31); }
};

template <int DIM> DEVICE matrix_bit bit_of(uint32_t triangle, int k)
{
    return DIM == 3 ? matrix_bit{ corner(triangle, k), corner(triangle, (k + 1) % 3) }
                    : matrix_bit{ (uint32_t)k, corner(triangle, k) };
}

/* Sets the bits of all edges of the cavity, or clears their words; end: the most conflicts of any tile. */
template <int T, bool SETS, typename S> DEVICE void mark_edges(S &s, bool go, const star_cavity &cavity, int end)
{
    const int lane = (int)threadIdx.x & (T - 1);
    for (int base = 0; base < end; base += T) {
        if (go && base + lane < cavity.conflicts) {
            const uint32_t t = s.triangle[s.cavity[base + lane]];
            for (int k = 0; k < S::dim; k++) {
                const matrix_bit edge = bit_of<S::dim>(t, k);
                if (SETS) {
                    atomicOr(&edge.word(s), edge.bit());
                } else {
                    edge.word(s) = 0;
                }
            }
        }
    }
    __syncwarp();
}

/* A number that no vertex has; at first among those never used. */
template <int T, typename S> DEVICE uint32_t free_number(S &s, bool go, int count)
{
    uint32_t number = none;
    for (int round = 0; round < 2; round++) {
        if (go && number == none) {
            for (int i = 0; i < S::words && number == none; i++) {
                uint32_t free = ~s.used[i];
                number = free != 0 ? (uint32_t)(i * 32 + __ffs((int)free) - 1) : none;
            }
        }
        if (!any(go && number == none)) {
            break;
        }
        find_used<T>(s, go && number == none, count);
    }
    return number;
}

/* Lists the border: edges without their reverse in the cavity; in 2D each end of the chain with the new vertex. */
template <int T, typename S> DEVICE void list_border(S &s, bool go, star_cavity &cavity, int end)
{
    const int lane = (int)threadIdx.x & (T - 1), most = S::vertices - 1;
    cavity.edges = 0;
    for (int base = 0; base < end; base += T) {
        const bool mine = go && base + lane < cavity.conflicts;
        const uint32_t t = mine ? s.triangle[s.cavity[base + lane]] : 0;
        for (int k = 0; k < S::dim; k++) {
            uint32_t a = corner(t, k), b = corner(t, k + 1 == S::dim ? 0 : k + 1);
            const matrix_bit reverse = S::dim == 3 ? matrix_bit{ b, a } : matrix_bit{ 1 - (uint32_t)k, a };
            const bool is_border = mine && (reverse.word(s) & reverse.bit()) == 0;
            const int at = append<T>(is_border, cavity.edges);
            if (is_border && at < S::triangles + 4) {
                if (S::dim == 2) {                   /* (a, new) at the start of the chain, (new, a) at its end */
                    b = k == 0 ? cavity.number : a;
                    a = k == 0 ? a : cavity.number;
                }
                s.border[at] = (typename S::pair)((a & most) << S::bits | (b & most));
            }
        }
    }
}

/* Finds the cavity of a point in the star of each tile that goes, of count triangles, and makes the point a vertex.
   Without DECIDES what floats leave open stays open. */
template <int T, bool DECIDES, typename S>
DEVICE int carve(S &s, const site &at, bool go, const point_of<S> &point, int count, star_cavity &cavity)
{
    int result = find_conflicts<T, DECIDES>(s, at, go, point, count, cavity);
    result |= cavity.conflicts == count && go ? star_hidden : 0;
    go = go && cavity.conflicts > 0 && result == 0;
    const int end = warp_max<T>(go ? cavity.conflicts : 0);
    __syncwarp();
    mark_edges<T, true>(s, go, cavity, end);
    cavity.number = free_number<T>(s, go, count);
    result |= go && cavity.number == none ? star_full : 0;
    list_border<T>(s, go, cavity, end);
    result |= go && count - cavity.conflicts + cavity.edges > S::triangles ? star_full : 0;
    __syncwarp();
    go = go && result == 0;
    mark_edges<T, false>(s, go, cavity, end);
    if (go && (threadIdx.x & (T - 1)) == 0) {
        set_vertex(s, cavity.number, point.id, point.p);
        s.used[cavity.number >> 5] |= 1u << (cavity.number & 31);
    }
    __syncwarp();
    return go ? star_changed : result;
}

/* Replaces the cavities of the tiles that go by the triangles from the first fans edges of their borders to the new
   vertex, and from the others to infinity; in the plane the border is the new edges.

   The last loop must not decrement count and then move triangle[count].  Where the insertion is inlined, ptxas
   V13.0.88 for sm_90 takes the addresses from the old count, with offsets of -4 and -16 bytes.  But it gives the old
   and the new count one register, and decrements that first: the simplex before the last one moves, and most of the
   zoo in cuda_test fails.  tests/cuda_inline.cu has that loop alone. */
template <int T, typename S>
DEVICE void fan(S &s, bool go, const star_cavity &cavity, int fans, int &count, unsigned walls)
{
    const int lane = (int)threadIdx.x & (T - 1), conflicts = cavity.conflicts, edges = cavity.edges;
    const int edge_end = warp_max<T>(go ? edges : 0);
    for (int base = 0; base < edge_end; base += T) {
        int i = base + lane;
        if (go && i < edges) {
            uint32_t edge = s.border[i], a = edge >> S::bits, b = edge & ((1u << S::bits) - 1);
            uint32_t c = S::dim == 3 && i < fans ? cavity.number : 0;
            int slot = i < conflicts ? s.cavity[i] : count + i - conflicts;
            s.triangle[slot] = pack(a, b, c);
            s.sphere[slot] = sphere_in(s, make_uint3(a, b, c), walls);
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

/* Makes a star one without triangles; used: of so many vertices, the vertex at infinity being the first. */
template <int T, typename S> DEVICE void clear_star(S &s, bool go, uint32_t vertices)
{
    const int lane = (int)threadIdx.x & (T - 1);
    for (int i = lane; go && i < S::vertices * S::words; i += T) {
        s.matrix[i] = 0;
    }
    for (uint32_t i = (uint32_t)lane; go && i < (uint32_t)S::words; i += T) {
        const uint32_t rest = vertices > i * 32 ? vertices - i * 32 : 0;
        s.used[i] = rest >= 32 ? ~0u : (1u << rest) - 1;
    }
    if (go && lane == 0) {
        set_vertex(s, 0, none, place_in<S>());       /* loads that are not used find the vertex at infinity there */
    }
}

/* Starts a star with three points, in the plane two: a finite triangle, and an infinite one on each of its edges, as
   the border of a cavity { 0, DIM + 1, 3 } that fan fills.  number: that of the lane's point as a vertex, or 0. */
template <int T, typename S> DEVICE void start(S &s, bool go, const point_of<S> &point, uint32_t number)
{
    int lane = (int)threadIdx.x & (T - 1);
    if (go) {
        clear_star<T>(s, true, S::dim + 1);
        if (number != 0) {
            set_vertex(s, number, point.id, point.p);
        }
    }
    __syncwarp();
    if (go && lane <= S::dim) {                      /* (1 2 3), (2 1 0), (3 2 0), (1 3 0), or (1 2), (2 0), (0 1) */
        const uint32_t a = (S::dim == 3 ? 0x1321u : 0x021u) >> 4 * lane & 3;
        const uint32_t b = (S::dim == 3 ? 0x3212u : 0x102u) >> 4 * lane & 3;
        s.border[lane] = (typename S::pair)(a << S::bits | b);
    }
    __syncwarp();
}

/* Returns how many vertices of a star have numbers below c. */
template <typename S> DEVICE int vertices_below(const S &s, uint32_t c)
{
    int below = __popc(s.used[c >> 5] & ((1u << (c & 31)) - 1));
    for (uint32_t j = 0; j < c >> 5; j++) {
        below += __popc(s.used[j]);
    }
    return below;
}

/* Stores the finished stars of the tiles that go. */
template <int T, typename S> DEVICE void finish(S &s, bool go, uint32_t v, int count, const store &out)
{
    int lane = (int)threadIdx.x & (T - 1), vertices = 0, owned = 0;
    bool closed = true;                              /* without infinite triangles: 0 is in used, but is not stored */
    find_used<T>(s, go, count);
    if (go && lane == 0) {
        s.id[0] = none;
    }
    for (int i = 0; go && i < s.words; i++) {
        vertices += __popc(s.used[i]);
    }
    __syncwarp();
    for (int t = lane; go && t < count; t += T) {
        bool mine = true;
        for (int k = 0; k < S::dim; k++) {
            uint32_t c = corner(s.triangle[t], k);
            closed = closed && c != 0;
            mine = mine && c != 0 && s.id[c] > v;
        }
        owned += mine;
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
                word[1 + vertices_below(s, (uint32_t)i) - closed] = s.id[i];
            }
        }
        for (int t = lane; t < count; t += T) {
            uint32_t packed = s.triangle[t] & verified;
            for (int k = 0; k < S::dim; k++) {
                packed |= (uint32_t)(vertices_below(s, corner(s.triangle[t], k)) - closed) << (10 * k);
            }
            word[1 + vertices + t] = packed;
        }
    }
    __syncwarp();
}

DEVICE void enqueue(const queue &q, bool put, uint32_t v)
{
    int length = 0;
    const int at = append<32>(put, length);
    uint32_t first = (threadIdx.x & 31) == 0 && length > 0 ? atomicAdd(q.count, (uint32_t)length) : 0;
    first = __shfl_sync(all_lanes, first, 0);
    if (put) {
        q.vertex[first + (uint32_t)at] = v;
    }
}

/* The determinant of three points relative to v. */
template <int DIM, typename REAL>
DEVICE REAL corner_size(const place<REAL> &a, const place<REAL> &b, const place<REAL> &c)
{
    REAL n[3];
    cross(a.x, b.x, n);
    return DIM == 3 ? product(c.x, n) : n[2];
}

/* |a x b|^2 / (|a|^2 |b|^2), and |det|^2 / (|a|^2 |b|^2 |c|^2); 0 if a length is 0. */
template <typename REAL> DEVICE float line_fatness(const place<REAL> &a, const place<REAL> &b)
{
    REAL n[3], size = square<3>(a.x) * square<3>(b.x);
    cross(a.x, b.x, n);
    return size > sizes<REAL>::least() * sizes<REAL>::least() ? (float)(square<3>(n) / size) : 0.0f;
}

template <int DIM, typename REAL>
DEVICE float fatness(const place<REAL> &a, const place<REAL> &b, const place<REAL> &c)
{
    REAL d = corner_size<DIM>(a, b, c) * rsqrt(square<3>(a.x)) * rsqrt(square<3>(b.x));
    d *= DIM == 3 ? rsqrt(square<3>(c.x)) : 1;
    return d * d > 0 ? (float)(d * d) : 0.0f;
}

/* Starts the star of each tile that goes, with points of the lanes below have, nearest first; the caller calls fan.
   1. Takes the nearest point.
   2. Takes the first that is not nearly on a line with it and v; with EXACT (T = 32) the farthest from that line.
   3. Takes the first that is not nearly in a plane with them; with EXACT the farthest from it, if the sign is known.
   Returns the lanes used, or 0 where there are no such points. */
template <int T, bool EXACT, typename S>
DEVICE unsigned start_from_lanes(S &s, const site &at, bool go, const point_of<S> &point, int have)
{
    const place_in<S> &p = point.p, a = tile_read<T>(p, 0);
    const float thin = 0.01f, flat = 1e-4f;
    const int lane = (int)threadIdx.x & (T - 1);
    const bool here = go && (EXACT ? point.id != none : lane < have);
    float fat = here && lane > 0 ? line_fatness(a, p) : 0.0f;
    unsigned vote = tile_ballot<T>(EXACT ? fat == tile_max<T>(fat) && fat > 1e-6f : fat > thin);
    const int second = vote != 0 ? __ffs((int)vote) - 1 : 0;
    const place_in<S> b = tile_read<T>(p, second);
    int third = second;
    go = go && vote != 0;
    if (S::dim == 3) {
        fat = here && vote != 0 ? fatness<S::dim>(a, b, p) : 0.0f;
        const float most = tile_max<T>(fat);
        vote = tile_ballot<T>(EXACT ? fat == most && fat > 0.0f : fat > flat || (fat == most && fat > 1e-8f));
        third = vote != 0 ? __ffs((int)vote) - 1 : 0;
        go = go && vote != 0;
    }
    bool turn = corner_size<S::dim>(a, b, tile_read<T>(p, third)) < 0;
    if (EXACT && go) {
        const record *r = at.all->point;
        const double *row[4] = { r[at.v].c, r[tile_read<T>(point.id, 0)].c, r[tile_read<T>(point.id, second)].c,
                                 r[tile_read<T>(point.id, third)].c };
        const int sign = pbw__orient_in(at.pool, S::dim, row, &at.all->grid);
        go = sign != 0 && sign != PBW__OPEN;
        turn = sign < 0;
    }
    const uint32_t number = lane == 0 ? 1 + turn : lane == second ? 2 - turn : S::dim == 3 && lane == third ? 3 : 0;
    start<T>(s, go, point, number);
    return go ? 1u | 1u << second | 1u << third : 0;
}

/* A box of the tree relative to v, grown by roundings of v and differences: multiples of 2^-24, of size 2 at most. */
struct span {
    float low[3], high[3];
};

template <int DIM> DEVICE span relative_box(const box &b, const float *v)
{
    span r;
    for (int k = 0; k < 3; k++) {
        r.low[k] = k < DIM ? b.low[k] - v[k] - 4.8e-7f : 0.0f;
        r.high[k] = k < DIM ? b.high[k] - v[k] + 4.8e-7f : 0.0f;
    }
    return r;
}

/* The square of the distance of such a box from v. */
template <int DIM> DEVICE float square_of_gap(const span &b)
{
    float square = 0.0f;
    for (int k = 0; k < DIM; k++) {
        const float gap = fmaxf(fmaxf(b.low[k], -b.high[k]), 0.0f);
        square = fmaf(gap, gap, square);
    }
    return square;
}

/* A rough point relative to another, and the square of its distance; nothing is fused, so all passes agree on it. */
DEVICE float rough_square(const float4 &p, const float *v, float *x)
{
    x[0] = __fsub_rn(p.x, v[0]);
    x[1] = __fsub_rn(p.y, v[1]);
    x[2] = __fsub_rn(p.z, v[2]);
    return __fmaf_rn(x[0], x[0], __fmaf_rn(x[1], x[1], __fmul_rn(x[2], x[2])));
}

/* The radius around q / 2 within which a point of the largest weight may be in conflict, grown by more than all
   roundings and the error of the centre. */
template <bool WEIGHTED> DEVICE float radius_of(float4 q, float heaviest)
{
    float size = root(fmaf(q.x, q.x, fmaf(q.y, q.y, q.z * q.z)));
    float radius = q.w < far_away ? fmaf(0.5f, size, slack * q.w) : 0.5f * q.w;
    return (WEIGHTED ? root(fmaf(radius, radius, heaviest)) : radius) * 1.00001f;
}

/* Bounds of the spheres of a star. */
template <int T, typename S> DEVICE span reach_of(const S &s, bool go, int count, float heaviest)
{
    span r = { { 0.0f, 0.0f, 0.0f }, { 0.0f, 0.0f, 0.0f } };
    int lane = (int)threadIdx.x & (T - 1);
    for (int t = lane; go && t < count; t += T) {
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
    for (int k = 0; k < S::dim; k++) {
        r.low[k] = tile_min<T>(r.low[k]) - 4.8e-7f;
        r.high[k] = 4.8e-7f - tile_min<T>(-r.high[k]);
    }
    return r;
}

/* Returns whether point p may be in conflict with some simplex of the star, by floats; all lanes of a tile go or none
   does, each with its own point.  The test is that of side, with the bound in the sum; that of a wall only adds.

   The bits of a float, less 1, are below those of infinity exactly if the float is above 0.  So the maximum of all
   tells whether all are above 0; a bool would be made a byte and back in each iteration. */
template <int T, typename S> DEVICE bool may_conflict(const S &s, bool go, int count, const place_in<S> &p)
{
    probe f = probe_of<S::dim, S::weighted>(p);
    float lift = fmaf(-1.25f, f.load, f.lift), size = -1.25f * f.size;
    uint32_t most = 0;
    int end = warp_max<T>(go ? count : 0), last = go ? count - 1 : 0;
#pragma unroll 4
    for (int t = 0; t < end; t++) {
        float4 q = s.sphere[t < last ? t : last];
        float least = fmaf(-q.x, f.x[0], fmaf(-q.y, f.x[1], fmaf(-q.z, f.x[2], fmaf(q.w, size, lift))));
        most = max(most, __float_as_uint(least) - 1);
    }
    return most >= __float_as_uint(HUGE_VALF) && go;
}

/* ------------------------------------------------------------------------------------------------------
   >>near         The first rung: 8 lanes a star, candidates from the list of its group.
   In: the vertices of a part, the lists.  Out: certified stars in the store; the other vertices in q[0].

   1. Points within the start radius are collected and sorted by distance.
   2. The nearest make the first corner, and the others are inserted.  All but the first 8 are tested against all
      spheres first: stars only shrink, so a point in conflict with nothing now will never be.
   3. The list is read again for points outside the start radius and within the bounds of the spheres.  Both passes
      calculate the distance alike, so no point occurs in both.
   4. The star is certified if its spheres lie within the box that the list covers, or reach out of it only where no
      points are.

   For most inputs floats decide nearly all signs, and a kernel without exact tests is quicker.  It lists the stars
   with an open sign in q[1]; a second kernel, which has exact tests, builds those again.  For points on surfaces
   (keeps) the rung ends after step 2, stores the star without the points that floats leave open, and certifies
   nothing.
   ------------------------------------------------------------------------------------------------------ */
const int near_triangles = 48, near_vertices = 32, near_points = 64, near_block = 128;
const int at_once = 2;                               /* groups that are loaded before their points are tested */

template <int DIM, bool WEIGHTED, typename REAL>
using near_star = star<DIM, WEIGHTED, near_triangles, near_vertices, near_points, REAL>;

/* A launch of the first rung.  Without EXACT it builds total vertices from first on, each stride-th, with EXACT those
   of q[1].  q[0] gets those that it leaves to the next rung, q[1] those that floats leave open. */
struct near_launch {
    star_build w;
    uint32_t first, stride, total;
    bool keeps;
};

/* A star of the first rung while its tile builds it. */
template <typename S> struct near_state {
    S &s;
    const near_launch &a;
    const uint32_t *list;                            /* the groups near v */
    near_list info;
    site at;
    record own;                                      /* v */
    int lane, length;
    float origin[3], heaviest;                       /* v; the largest weight relative to v's */
    bool go, walking, changed;                       /* walking: step 3; changed: reach is out of date */
    float start2;                                    /* the square of the start radius */
    int have, cursor;                                /* points collected, and those of them already tried */
    int count, stored, position;                     /* triangles; points waiting; groups of the list read */
    point_of<S> candidate;                           /* of each lane */
    uint32_t group_here;
    unsigned pending, groups;                        /* lanes with a candidate to insert; with a group to read */
    span reach;
};
const int near_lanes = 8;

/* Appends the points of a group closer than the start radius.  Lanes without one read v: a branch takes longer. */
template <typename S> DEVICE void collect_group(near_state<S> &n, uint32_t group, bool here)
{
    uint32_t p = group * group_size + (uint32_t)n.lane;
    const bool other = here && p < n.a.w.all.count && p != n.at.v;
    float x[3], d = rough_square(n.a.w.all.rough[other ? p : n.at.v], n.origin, x);
    const bool take = other && d < n.start2;
    const int at = append<near_lanes>(take, n.have);
    if (take && at < near_points) {
        ((uint32_t *)n.s.sphere)[at] = p;            /* free before there is a star */
        n.s.scratch[at] = (__float_as_uint(d) & ~63u) | (uint32_t)at;
    }
}

/* Step 1: the points within the start radius, which shrinks until there is room for them.  A star is given up if its
   points are too close for floats to tell apart. */
template <typename S> DEVICE void collect_close(near_state<S> &n)
{
    int shrinks = 0;
    for (bool again = n.go; any(again); shrinks++) {
        n.have = again ? 0 : n.have;
        for (int base = 0; any(again && base < (int)n.info.close); base += near_lanes) {
            uint32_t group = again && base + n.lane < n.length ? n.list[base + n.lane] : none;
            bool close = false;
            if (group != none) {
                span b = relative_box<S::dim>(n.a.w.boxes.level[0][group], n.origin);
                close = square_of_gap<S::dim>(b) * 0.99999f < n.start2;
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
template <typename S> DEVICE void sort_collected(near_state<S> &n)
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

/* Loads the next candidates that may be in conflict, until each tile has some, or has none left at hand. */
template <typename S> DEVICE void next_candidates(near_state<S> &n)
{
    const int T = near_lanes;
    for (;;) {
        const int rest = n.walking ? n.stored : n.have - n.cursor, take = rest < T ? rest : T;
        const bool feed = n.go && n.pending == 0 && rest > 0;
        if (!any(feed)) {
            return;
        }
        __syncwarp();
        uint32_t next = n.candidate.id;
        if (feed) {
            next = n.lane < take ? n.s.scratch[(n.walking ? n.stored - take : n.cursor) + n.lane] : none;
            n.stored -= n.walking ? take : 0;
        }
        n.candidate = candidate_at<S>(n.at, n.own, next);
        const bool may = may_conflict<T>(n.s, feed, n.count, n.candidate.p);
        unsigned vote = tile_ballot<T>(feed && next != none && may);
        n.pending = feed ? vote : n.pending;
        n.cursor += feed && !n.walking ? T : 0;
    }
}

/* Finds which of the next 8 groups of the list touch the reach of the star. */
template <typename S> DEVICE void next_groups(near_state<S> &n, bool load)
{
    bool touches = false;
    if (load && n.position + n.lane < n.length) {
        n.group_here = n.list[n.position + n.lane];
        span b = relative_box<S::dim>(n.a.w.boxes.level[0][n.group_here], n.origin);
        touches = true;
        for (int k = 0; k < S::dim; k++) {
            touches = touches && b.low[k] <= n.reach.high[k] && b.high[k] >= n.reach.low[k];
        }
    }
    unsigned vote = tile_ballot<near_lanes>(touches);
    n.groups = load ? vote : n.groups;
    n.position += load ? near_lanes : 0;
}

/* Stores the points of several groups that are within the reach; of several, so that their loads overlap. */
template <typename S> DEVICE void store_points(near_state<S> &n, bool fill)
{
    const int T = near_lanes;
    uint32_t other[at_once];
    float4 place_of[at_once];
    for (int i = 0; i < at_once; i++) {
        bool is_there = fill && n.groups != 0;
        uint32_t from = tile_read<T>(n.group_here, is_there ? __ffs((int)n.groups) - 1 : 0);
        n.groups &= is_there ? n.groups - 1 : n.groups;
        other[i] = from * group_size + (uint32_t)n.lane;
        other[i] = is_there && other[i] < n.a.w.all.count && other[i] != n.at.v ? other[i] : none;
        place_of[i] = n.a.w.all.rough[other[i] != none ? other[i] : n.at.v];
    }
    for (int i = 0; i < at_once; i++) {
        float x[3];
        bool take = rough_square(place_of[i], n.origin, x) >= n.start2 && other[i] != none;
        for (int k = 0; k < S::dim; k++) {
            take = take && x[k] >= n.reach.low[k] && x[k] <= n.reach.high[k];
        }
        const int to = append<T>(take, n.stored);
        if (take) {
            n.s.scratch[to] = other[i];
        }
    }
}

/* Step 3: walks on through the list, for all tiles of the block that have room. */
template <typename S> DEVICE void walk_list(near_state<S> &n)
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
template <typename S> DEVICE bool certify(near_state<S> &n)
{
    const box b = n.a.w.boxes.level[0][n.at.v / group_size];
    span covered;
    for (int k = 0; k < 3; k++) {
        const float low = b.low[k] - n.info.reach, high = b.high[k] + n.info.reach;
        covered.low[k] = low <= 0.0f ? -HUGE_VALF : low - n.origin[k] + 4.8e-7f;
        covered.high[k] = high >= n.a.w.all.high[k] ? HUGE_VALF : high - n.origin[k] - 4.8e-7f;
    }
    bool certified = true;
    for (int t = n.lane; n.go && t < n.count; t += near_lanes) {
        float4 q = n.s.sphere[t];
        float c[3] = { 0.5f * q.x, 0.5f * q.y, 0.5f * q.z }, radius = radius_of<S::weighted>(q, n.heaviest);
        bool inside = true;
        for (int k = 0; k < S::dim; k++) {
            inside = inside && c[k] - radius > covered.low[k] && c[k] + radius < covered.high[k];
        }
        inside = inside || is_wall(q);
        n.s.triangle[t] |= inside && !n.a.keeps ? verified : 0;
        certified = certified && inside;
    }
    return tile_ballot<near_lanes>(!certified) == 0;
}

/* Gives a tile its vertex; nothing is collected yet. */
template <typename S> DEVICE void open_near(near_state<S> &n, uint32_t v, bool valid)
{
    const space &all = n.a.w.all;
    const uint32_t row = v / group_size - n.a.w.out.first / group_size;
    const float4 rough = all.rough[v];
    n.own = all.point[v];
    n.at = { &all, v, walls_of<S::dim>(all, n.own), NULL };
    n.list = n.a.w.lists + (size_t)row * list_size;
    n.info = n.a.w.infos[row];
    n.length = (int)n.info.length;
    n.lane = (int)threadIdx.x & (near_lanes - 1);
    n.origin[0] = rough.x, n.origin[1] = rough.y, n.origin[2] = rough.z;
    n.heaviest = S::weighted ? (float)((all.heaviest - n.own.c[S::dim]) * (all.unit * all.unit)) * 1.000001f : 0.0f;
    n.go = valid && n.length > 0 && *n.a.w.out.stop == 0;
    n.start2 = n.info.start * n.info.start;
    n.have = 0;
}

/* Step 2: starts the star with the nearest points that are not nearly flat with v; the others are candidates. */
template <typename S> DEVICE void start_near(near_state<S> &n)
{
    const int T = near_lanes;
    n.candidate = candidate_at<S>(n.at, n.own, n.go && n.lane < n.have ? n.s.scratch[n.lane] : none);
    const unsigned used = start_from_lanes<T, false>(n.s, n.at, n.go, n.candidate, n.have);
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

template <int DIM, bool WEIGHTED, bool EXACT>        /* registers and shared memory bound the blocks */
__global__ void __launch_bounds__(near_block, EXACT ? 4 : DIM == 2 ? 8 : WEIGHTED ? 6 : 7)
near_kernel(const __grid_constant__ near_launch a)
{
    typedef near_star<DIM, WEIGHTED, rung_real<EXACT> > star_type;
    extern __shared__ float4 shared_words[];
    const int T = near_lanes;
    near_state<star_type> n = { ((star_type *)shared_words)[threadIdx.x / T], a };
    const uint32_t tile = (uint32_t)thread_number() / T;
    const bool valid = tile < a.total;
    const uint32_t item = valid ? tile : a.total - 1;
    bool open = false, kept = false;
    open_near(n, EXACT ? a.w.q[1].vertex[item] : a.first + item * a.stride, valid);
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
        star_cavity cavity = { 0, DIM + 1, 3 };      /* of start */
        int fans = 1;
        if (!starting) {
            int from = now ? __ffs((int)n.pending) - 1 : 0;
            n.pending &= n.pending - 1;
            const point_of<star_type> next = tile_read<T>(n.candidate, from);
            int result = carve<T, EXACT>(n.s, n.at, now, next, n.count, cavity);
            now = result == star_changed;
            fans = cavity.edges;
            n.changed = n.changed || now;
            open = open || (!EXACT && (result & star_open) != 0);
            kept = kept || (a.keeps && (result & star_full) != 0);
            n.go = n.go && (result & (a.keeps ? star_full : ~star_changed)) == 0;
        }
        fan<T>(n.s, now, cavity, fans, n.count, n.at.walls);
    }
    const bool certified = certify(n);
    const uint32_t v = n.at.v;
    finish<T>(n.s, n.go || kept, v, n.count, a.w.out);
    enqueue(a.w.q[0], !a.keeps && valid && n.lane == 0 && !open && !(n.go && certified),
            v | (n.go ? stored_mark : 0));
    if (!EXACT) {
        enqueue(a.w.q[1], !a.keeps && valid && n.lane == 0 && open, v);
    }
}

/* No sample is taken of fewer points than sampled_from: any rung builds them soon. */
const uint32_t sample_size = 1024, sampled_from = 1u << 14;

/* Copies the points that a mesh keeps, while the device is at work. */
void keep_points(call &c)
{
    if (c.job->keep != NULL && c.card == 0 && c.job->kept_points == NULL) {
        pbw_status status = c.job->keep(c.job);
        require(c, status == PBW_OK, status, "the points could not be kept");
    }
}

/* Clears the store and the queues. */
void clear_stars(call &c, const star_build &w)
{
    fill(c, w.q[0].count, 0, 3);
    fill(c, w.out.used, 0, 1);
    fill(c, w.out.owned + w.out.size(), 0, 1);
    fill(c, w.out.place, 0xff, w.out.size());
}

/* The first rung for total vertices from first on, each stride-th; with EXACT for the first total of q[1]. */
template <int DIM, bool WEIGHTED, bool EXACT>
void launch_near(call &c, const star_build &w, uint32_t first, uint32_t stride, uint32_t total, bool keeps = false)
{
    const size_t bytes = sizeof(near_star<DIM, WEIGHTED, rung_real<EXACT> >);
    static_assert(bytes * (near_block / near_lanes) <= 48 << 10,
                  "the stars of a block fit what every device has of shared memory");
    /* a small launch ends with its slowest block, and a block with its slowest star */
    shape s = over((size_t)total * near_lanes, total < 1u << 14 ? 32 : near_block);
    s.bytes = bytes * (s.threads / near_lanes);
    launch(c, "near stars", near_kernel<DIM, WEIGHTED, EXACT>, s, near_launch{ w, first, stride, total, keeps });
}

/* Returns whether the first rung certifies less than half of a sample, as where points lie on surfaces and curves. */
template <int DIM, bool WEIGHTED> bool sample_reaches_far(call &c, const star_build &w)
{
    clear_stars(c, w);
    launch_near<DIM, WEIGHTED, false>(c, w, w.out.first, w.out.size() / sample_size, sample_size);
    const uint2 counts = read_back(c, (const uint2 *)w.q[0].count, PBW_STAGE_BUILD, 0.0);
    if (counts.y == 0 || counts.x + counts.y <= sample_size / 2) {
        return counts.x > sample_size / 2;
    }
    launch_near<DIM, WEIGHTED, true>(c, w, 0, 1, counts.y);
    return read_back(c, w.q[0].count, PBW_STAGE_BUILD, 0.0) > sample_size / 2;
}

/* The first rung: all stars of the part, then those that floats left open.  Returns how many it leaves in q[0]. */
template <int DIM, bool WEIGHTED> uint32_t build_near_stars(call &c, const star_build &w)
{
    const uint32_t chunk = 1u << 22;
    clear_stars(c, w);
    c.mesh->stars[0] = w.out.size();
    for (uint32_t first = w.out.first; first < w.out.end; first += chunk) {
        const uint32_t count = w.out.end - first < chunk ? w.out.end - first : chunk;
        const bool more = first + count < w.out.end;
        launch_near<DIM, WEIGHTED, false>(c, w, first, 1, count);
        if (first == w.out.first && more) {          /* one ahead: the host has time for its part */
            continue;
        }
        keep_points(c);
        if (more) {
            wait(c, PBW_STAGE_BUILD, 0.7 * (double)(first - w.out.first) / (double)w.out.size());
        }
    }
    const uint32_t open = read_back(c, w.q[1].count, PBW_STAGE_BUILD, 0.7);
    if (open > 0) {
        launch_near<DIM, WEIGHTED, true>(c, w, 0, 1, open);
    }
    record_mark(c, 3);
    return read_back(c, w.q[0].count, PBW_STAGE_BUILD, 0.8);
}

/* ------------------------------------------------------------------------------------------------------
   >>far          The second and third rung: a warp or more a star, candidates from a search of the tree.
   In: vertices of a queue, with a star in the store or without.  Out: certified stars in the store; the vertices that
   fail in another queue.

   The star is that of the first rung, or starts from the neighbours of v on the curve.  For each simplex that is not
   verified the tree is searched depth first for points in conflict with it; if there are none, it is verified.  A
   simplex without conflicts is in the result: so nothing is searched twice, and when all simplices are verified, the
   star is certified, large or small.  A cap on the steps of a search keeps the total work linear.

   With t the point of a box where |x|^2 - q . x is least, axis by axis, and h = 2^-20 Q, for any x of the box

       |x|^2 - q . x - h |x|_1 >= sum over axes of t (t - q) - h |t| - h^2 / 4,

   because |x|^2 - q . x >= t (t - q) + (x - t)^2 on each axis and (x - t)^2 - h |x - t| >= -h^2 / 4.  For a simplex
   so flat that h is large, it is closer to take the largest |x|_1 of the box instead of |t|_1 + h / 4.
   ------------------------------------------------------------------------------------------------------ */
/* Stars live in shared memory, or without SHARED in scratch.  blocks: on a multiprocessor. */
template <int TRIANGLES, int WARPS, int BLOCKS, bool EXACT, bool SHARED> struct rung {
    static const int triangles = TRIANGLES, vertices = TRIANGLES / 2, warps = WARPS, blocks = BLOCKS;
    static const bool exact = EXACT, shared = SHARED;
};
typedef rung<128, 1, 24, false, true> quick_rung;
typedef rung<256, 4, 4, true, true> far_rung;
typedef rung<2048, 8, 2, true, false> last_rung;

/* What the warps of a block share, stored after their stacks. */
struct block_state {
    int count, verdict, current[8];                  /* current: the simplex that a warp searches for, or -1 */
    uint32_t waits[8];                               /* whether a warp has points to insert */
    int changed;
};

template <int DIM, bool WEIGHTED, typename RUNG>
using far_star = star<DIM, WEIGHTED, RUNG::triangles, RUNG::vertices,
                      RUNG::warps * stack_size + (int)(sizeof(block_state) / sizeof(uint32_t)),
                      rung_real<RUNG::exact> >;

template <int WARPS> DEVICE void sync_warps()
{
    WARPS == 1 ? __syncwarp() : __syncthreads();
}

/* Returns whether a simplex, not a wall, may be in conflict with a point in a box; weight: the largest less v's. */
template <int DIM, bool WEIGHTED> DEVICE bool box_may_conflict(const float4 &sphere, const span &b, float weight)
{
    float q[3] = { sphere.x, sphere.y, sphere.z }, size = sphere.w;
    float sum = 0.0f, squares = 0.0f, ones = 0.0f, most = 0.0f;
    bool infinite = size >= far_away;
    float h = slack * size;
    for (int k = 0; k < DIM; k++) {
        float at = infinite ? (q[k] > 0.0f ? b.high[k] : b.low[k]) : fminf(fmaxf(0.5f * q[k], b.low[k]), b.high[k]);
        sum += infinite ? -at * q[k] : at * (at - q[k]);
        squares = fmaf(at, at, squares);
        ones += fabsf(at);
        most += fmaxf(fabsf(b.low[k]), fabsf(b.high[k]));
    }
    sum -= infinite || !WEIGHTED ? 0.0f : weight;
    squares = infinite ? 0.0f : squares + (WEIGHTED ? fabsf(weight) : 0.0f);
    const float error = infinite ? 2.0f * h * most : fminf(2.0f * h * ones + h * h, 2.0f * h * most);
    return !(sum > 2.0f * slack * squares + error);
}

/* Finds four points that span the space: the first point, then the one farthest from the span of those before. */
template <int DIM> __global__ void seed_kernel(const __grid_constant__ space s, int found, unsigned long long *seed)
{
    unsigned long long best = 0;
    const record first = s.point[0];
    place<double> base[2];
    for (int i = 1; i < found; i++) {
        base[i - 1] = relative<DIM, double>(s, first, s.point[(uint32_t)seed[i]]);
    }
    for (size_t i = thread_number(); i < s.count; i += (size_t)gridDim.x * blockDim.x) {
        place<double> p = relative<DIM, double>(s, first, s.point[i]);
        double d = found == 1 ? square<3>(p.x)
                 : found == 2 ? line_fatness(base[0], p) * square<3>(p.x) : fabs(corner_size<3>(base[0], base[1], p));
        best = max(best, (unsigned long long)__float_as_uint((float)d) << 32 | i);
    }
    best = tile_max<32>(best);
    if ((threadIdx.x & 31) == 0) {
        atomicMax(&seed[found], best);
    }
}

/* Inserts a point into the star of a warp. */
template <typename S> DEVICE int insert(S &s, const site &at, const point_of<S> &point, int &count)
{
    star_cavity cavity;
    int result = carve<32, true>(s, at, true, point, count, cavity);
    fan<32>(s, result == star_changed, cavity, cavity.edges, count, at.walls);
    return result;
}

/* A star of v from 28 points at growing distances along the curve, so that it is bounded in all directions from the
   start; false if they and, with EXACT, the seeds span no simplex. */
template <bool EXACT, typename S>
DEVICE bool start_on_curve(S &s, const site &at, const unsigned long long *seed, point_of<S> &point, int &count)
{
    const uint32_t v = at.v, points = at.all->count;
    const record own = at.all->point[v];
    const int lane = (int)threadIdx.x & 31, step = lane / 2 + 1;
    const float far = step <= 6 ? (float)step : 6.0f * powf((float)points / 12.0f, (float)(step - 6) / 8.0f);
    const uint32_t offset = (uint32_t)far + (step > 6 ? 1 : 0);
    uint32_t *order = s.scratch, id = none;
    if (lane < 28) {
        id = (lane & 1) != 0 ? (v + offset < points ? v + offset : none) : (offset <= v ? v - offset : none);
    }
    point = candidate_at<S>(at, own, id);
    uint32_t key = id != none ? (__float_as_uint((float)square<S::dim>(point.p.x)) & ~31u) | (uint32_t)lane : none;
    int before = 0, have = __popc(__ballot_sync(all_lanes, id != none));
    for (int i = 0; i < 32; i++) {
        before += __shfl_sync(all_lanes, key, i) < key;
    }
    order[lane] = none;
    __syncwarp();
    if (id != none) {
        order[before] = id;
    }
    __syncwarp();
    point = candidate_at<S>(at, own, order[lane]);
    __syncwarp();
    bool started = start_from_lanes<32, false>(s, at, true, point, have) != 0;
    if (!started && EXACT) {                         /* with four seeds that span the space */
        if (point.id == none) {
            uint32_t other = lane - have > S::dim ? none : lane == have ? 0 : (uint32_t)seed[lane - have];
            point = candidate_at<S>(at, own, other == v ? none : other);
        }
        started = start_from_lanes<32, true>(s, at, true, point, 32) != 0;
    }
    fan<32>(s, started, star_cavity{ 0, S::dim + 1, 3 }, 1, count, at.walls);
    return started;
}

/* The star of a warp as the store has it; returns its triangles. */
template <typename S> DEVICE int start_from_store(S &s, const site &at, const store &in)
{
    const int lane = (int)threadIdx.x & 31;
    const record own = at.all->point[at.v];
    const uint32_t *word = in.word + (size_t)in.place[at.v - in.first] * 4;
    const uint32_t vertices = word[0] & 0xffff, first = word[1] == none ? 0 : 1;
    const int count = (int)(word[0] >> 16);
    clear_star<32>(s, true, vertices + first);
    for (uint32_t i = (uint32_t)lane; i < vertices; i += 32) {
        if (word[1 + i] != none) {
            const point_of<S> vertex = candidate_at<S>(at, own, word[1 + i]);
            set_vertex(s, i + first, vertex.id, vertex.p);
        }
    }
    __syncwarp();
    for (int t = lane; t < count; t += 32) {
        const uint32_t packed = word[1 + vertices + (uint32_t)t] + pack(first, first, S::dim == 3 ? first : 0);
        s.triangle[t] = packed;
        s.sphere[t] = sphere_in(s, corners<S::dim>(packed), at.walls);
    }
    __syncwarp();
    return count;
}

enum { far_busy, far_certified, far_hidden, far_lost, far_capped };

/* A launch of a later rung: total stars, each with at most cap search steps.  After more than limit failures the
   remaining stars are not tried.  Without shared memory stars live in scratch. */
struct rung_launch {
    star_build w;
    const uint32_t *vertex;
    uint32_t total, limit;
    int cap;
    void *scratch;
    pbw__digit *pool;
    queue failed;
};

/* A star of these rungs while the warps of a block build it, as one of the warps sees it. */
template <typename S> struct far_state {
    S &s;
    const rung_launch &a;
    block_state &shared;
    uint32_t *stack;                                 /* nodes of the tree, level << 29 | number */
    site at;
    record own;                                      /* v */
    float origin[3];
    double own_weight;                               /* v's, relative to the heaviest */
    int lane, warp, count;
    point_of<S> candidate;                           /* of each lane */
    unsigned pending, hit;                           /* lanes with a candidate to insert, with a group to search */
    uint32_t node;                                   /* the group of lane 0 */
    uint32_t word;                                   /* the triangle of the current simplex */
    int t, depth, spent;                             /* the current simplex, or -1; nodes on the stack; steps */
};

/* The star of v, with nothing in it yet. */
template <int WARPS, typename S>
DEVICE far_state<S> open_far(S &s, const rung_launch &a, uint32_t v, pbw__digit *pool)
{
    const space &all = a.w.all;
    const int lane = (int)threadIdx.x & 31, warp = (int)threadIdx.x / 32;
    const record own = all.point[v];
    const float4 rough = all.rough[v];
    return { s, a, *(block_state *)(s.scratch + WARPS * stack_size), s.scratch + warp * stack_size,
             { &all, v, walls_of<S::dim>(all, own), pool }, own, { rough.x, rough.y, rough.z },
             (own.c[S::dim] - all.heaviest) * (all.unit * all.unit), lane, warp, 0, { none, {} },
             0, 0, 0, 0, -1, 0, 0 };
}

/* The first warp makes the star of the store, or else one from points on the curve. */
template <bool EXACT, typename S> DEVICE void start_far(far_state<S> &n, bool resume)
{
    if (n.warp == 0) {
        bool started = true;
        int count = 0;
        if (resume) {
            count = start_from_store(n.s, n.at, n.a.w.out);
        } else {
            started = start_on_curve<EXACT>(n.s, n.at, n.a.w.seed, n.candidate, count);
            n.pending = started ? __ballot_sync(all_lanes, n.candidate.id != none) : 0;
        }
        if (n.lane == 0) {
            n.shared.count = count;
            n.shared.verdict = started ? far_busy : far_lost;
            n.shared.changed = !resume;
        }
    }
}

/* Returns whether the current simplex has been deleted. */
template <typename S> DEVICE bool is_gone(const far_state<S> &n, int count)
{
    return n.t >= 0 && (n.t >= count || n.s.triangle[n.t] != n.word);
}

/* Takes the nearest of the warp's candidates. */
template <typename S> DEVICE point_of<S> take_nearest(far_state<S> &n)
{
    const bool waits = (n.pending >> n.lane & 1) != 0;
    const float length = waits ? (float)square<S::dim>(n.candidate.p.x) : HUGE_VALF, least = tile_min<32>(length);
    const int from = __ffs((int)(__ballot_sync(all_lanes, length == least) & n.pending)) - 1;
    n.pending &= ~(1u << from);
    return tile_read<32>(n.candidate, from);
}

template <typename S> DEVICE bool is_vertex(const S &s, uint32_t id)
{
    bool known = false;
    for (int i = (int)threadIdx.x & 31; i < S::vertices; i += 32) {
        known = known || (i > 0 && (s.used[i >> 5] >> (i & 31) & 1) != 0 && s.id[i] == id);
    }
    return any(known);
}

/* Inserts the warp's candidates, while those of the others wait. */
template <typename S> DEVICE void insert_pending(far_state<S> &n)
{
    int count = n.shared.count, verdict = far_busy;
    bool touched = false;
    if (is_gone(n, count)) {                         /* another warp has changed it */
        n.pending = 0;
    }
    while (n.pending != 0 && verdict == far_busy) {
        const point_of<S> next = take_nearest(n);
        if (is_vertex(n.s, next.id)) {               /* the search finds vertices too */
            continue;
        }
        int result = insert(n.s, n.at, next, count);
        verdict = S::weighted && result == star_hidden ? far_hidden
                : (result & ~star_changed) != 0 ? far_lost : far_busy;
        if (result == star_changed) {
            touched = true;
            n.pending = __ballot_sync(all_lanes, may_conflict<32>(n.s, true, count, n.candidate.p)
                                                     && (n.pending >> n.lane & 1) != 0);
        }
        n.spent += 4;
    }
    __syncwarp();
    if (n.lane == 0) {
        n.shared.count = count;
        n.shared.verdict = verdict;
        n.shared.changed = n.shared.changed || touched;
    }
    __syncwarp();
}

template <bool EXACT, int WARPS, typename S> DEVICE void insert_in_turns(far_state<S> &n)
{
    for (int turn = 0; turn < WARPS; turn++) {
        if (WARPS > 1) {
            if (n.lane == 0 && turn == 0) {
                n.shared.waits[n.warp] = n.pending;
            }
            __syncthreads();
            if (n.shared.waits[turn] == 0) {
                continue;
            }
        }
        if (turn == n.warp && n.pending != 0 && n.shared.verdict == far_busy) {
            insert_pending(n);
        }
    }
}

/* Where the current simplex is finished, makes one current that no other warp has. */
template <int WARPS, typename S> DEVICE void take_simplex(far_state<S> &n)
{
    if (WARPS > 1) {
        if (n.lane == 0) {
            n.shared.current[n.warp] = n.t;
        }
        __syncthreads();
    }
    if (n.t >= 0) {
        return;
    }
    int skip = 0;
    for (int w = 0; w < n.warp; w++) {
        skip += n.shared.current[w] < 0;
    }
    for (int base = 0; base < n.count && n.t < 0; base += 32) {
        bool open = base + n.lane < n.count && (n.s.triangle[base + n.lane] & verified) == 0;
        for (int w = 0; w < WARPS && WARPS > 1; w++) {
            open = open && n.shared.current[w] != base + n.lane;
        }
        unsigned vote = __ballot_sync(all_lanes, open);
        for (; skip > 0 && vote != 0; skip--) {
            vote &= vote - 1;
        }
        n.t = vote != 0 ? base + __ffs((int)vote) - 1 : -1;
    }
    if (n.t >= 0) {
        n.word = n.s.triangle[n.t];
        n.depth = is_wall(n.s.sphere[n.t]) ? 0 : 1;
        n.hit = 0;
        if (n.lane == 0) {
            n.stack[0] = (uint32_t)n.a.w.boxes.levels << 29;
        }
        __syncwarp();
    }
}

/* Tests the points of 4 groups. */
template <bool EXACT, typename S> DEVICE void search_groups(far_state<S> &n)
{
    uint32_t group = none, id;
    for (int i = 0; i < 4; i++) {
        group = n.lane / 8 == i && n.hit != 0 ? n.node + (uint32_t)__ffs((int)n.hit) - 1 : group;
        n.hit &= n.hit - 1;
    }
    id = group != none ? group * group_size + (uint32_t)(n.lane & 7) : none;
    id = id < n.a.w.all.count && id != n.at.v ? id : none;
    for (int k = 0; k < S::dim; k++) {
        const uint32_t c = corner(n.word, k);
        id = c != 0 && n.s.id[c] == id ? none : id;
    }
    n.candidate = candidate_at<S>(n.at, n.own, id);
    int answer = id != none ? side(n.s.sphere[n.t], probe_of<S::dim, S::weighted>(n.candidate.p)) : 0;
    if (EXACT && answer == open_sign) {              /* a flat simplex on the hull leaves many points open */
        const site without_pool = { n.at.all, n.at.v, n.at.walls, NULL };
        answer = decide(n.s, without_pool, n.count, n.t, n.candidate);
    }
    n.pending = __ballot_sync(all_lanes, answer != 0);
}

/* Tests 32 boxes: pushes those that may have points in conflict, the nearest last. */
template <typename S> DEVICE void search_boxes(far_state<S> &n)
{
    const tree &boxes = n.a.w.boxes;
    const uint32_t top = n.stack[--n.depth], level = (top >> 29) - 1;
    n.node = (top & 0x1fffffffu) * 32;
    const uint32_t child = n.node + (uint32_t)n.lane;
    float distance = HUGE_VALF;
    bool visit = false;
    if (child < boxes.size[level]) {
        box b = boxes.level[level][child];
        span r = relative_box<S::dim>(b, n.origin);
        const float own = (float)n.own_weight, weight = b.weight - own + slack * fabsf(own);   /* rounded up */
        visit = box_may_conflict<S::dim, S::weighted>(n.s.sphere[n.t], r, weight);
        distance = visit ? square_of_gap<S::dim>(r) : HUGE_VALF;
    }
    __syncwarp();
    const unsigned vote = __ballot_sync(all_lanes, visit);
    if (level == 0) {
        n.hit = vote;
        return;
    }
    const float least = tile_min<32>(distance);
    unsigned nearest = __ballot_sync(all_lanes, visit && distance == least);
    nearest &= ~nearest + 1;                         /* one of them */
    if (visit) {
        const unsigned before = (nearest >> n.lane & 1) != 0 ? all_lanes : lanes_below<32>();
        n.stack[n.depth + __popc(vote & ~nearest & before)] = level << 29 | child;
    }
    n.depth += __popc(vote);
    __syncwarp();
}

/* Builds a star by all warps of a block: each searches for points in conflict with its own simplex, then they insert
   in turns. */
template <bool EXACT, int WARPS, typename S> DEVICE int build_far(far_state<S> &n, bool resume)
{
    start_far<EXACT>(n, resume);
    sync_warps<WARPS>();
    for (;;) {
        insert_in_turns<EXACT, WARPS>(n);
        sync_warps<WARPS>();
        n.count = n.shared.count;
        if (n.shared.verdict != far_busy) {
            return n.shared.verdict;
        }
        n.pending = 0;
        n.t = is_gone(n, n.count) ? -1 : n.t;
        take_simplex<WARPS>(n);
        if (WARPS == 1 ? n.t < 0 : __syncthreads_and(n.t < 0) != 0) {
            return far_certified;
        }
        while (n.t >= 0 && n.pending == 0 && n.spent <= n.a.cap && (n.hit != 0 || n.depth > 0)) {
            n.spent++;
            if ((n.spent & 63) == 0 && *n.a.w.out.stop != 0) {
                n.spent = n.a.cap + 1;
            }
            if (n.hit != 0) {
                search_groups<EXACT>(n);
            } else {
                search_boxes(n);
            }
        }
        sync_warps<WARPS>();                         /* all have read the star */
        if (n.lane == 0 && n.t >= 0 && n.spent > n.a.cap) {
            n.shared.verdict = far_capped;
        } else if (n.lane == 0 && n.t >= 0 && n.pending == 0) {      /* no point is in conflict with it */
            n.s.triangle[n.t] = n.word | verified;
        }
        n.t = n.pending != 0 ? n.t : -1;
        sync_warps<WARPS>();
    }
}

/* Stars in shared memory have a block each; for stars in scratch each block takes one vertex after another.
   Only the warp that inserts calls the exact stages, so one pool serves a block. */
template <int DIM, bool WEIGHTED, typename RUNG>
__global__ void __launch_bounds__(32 * RUNG::warps, RUNG::blocks) far_kernel(const __grid_constant__ rung_launch a)
{
    typedef far_star<DIM, WEIGHTED, RUNG> star_type;
    extern __shared__ float4 shared_words[];
    star_type &s = *(RUNG::shared ? (star_type *)shared_words : (star_type *)a.scratch + blockIdx.x);
    pbw__digit *digits = a.pool == NULL ? NULL : a.pool + (blockIdx.x * 32 + (threadIdx.x & 31)) * (size_t)PBW__POOL;
    __shared__ bool ends;
    for (uint32_t i = blockIdx.x; i < a.total; i += gridDim.x) {
        uint32_t entry = a.vertex[i], v = entry & ~stored_mark;
        bool resume = entry != v && a.w.out.place[v - a.w.out.first] != none;      /* none: the store was full */
        if (threadIdx.x == 0) {
            ends = *(volatile uint32_t *)a.failed.count > a.limit || *a.w.out.stop != 0;
        }
        sync_warps<RUNG::warps>();
        if (ends) {
            return;
        }
        far_state<star_type> n = open_far<RUNG::warps>(s, a, v, digits);
        const int verdict = build_far<RUNG::exact, RUNG::warps>(n, resume);
        if (threadIdx.x < 32) {
            bool fails = verdict == far_lost || verdict == far_capped, stays = verdict != far_lost;
            if (verdict == far_capped || (verdict == far_certified && n.shared.changed != 0)) {
                finish<32>(s, true, v, n.count, a.w.out);
            }
            if (verdict == far_hidden && threadIdx.x == 0) {
                a.w.out.place[v - a.w.out.first] = hidden;
                a.w.out.owned[v - a.w.out.first] = 0;
            }
            enqueue(a.failed, fails && threadIdx.x == 0, stays ? v | stored_mark : entry);
            enqueue(a.w.q[2], verdict == far_certified && threadIdx.x == 0, v);
        }
        sync_warps<RUNG::warps>();
    }
}

/* Caps on the search steps of a warp: each tests 32 boxes or points; an insertion counts as 4 steps. */
const int quick_cap = 1024, far_cap = 4096, last_cap[2] = { 1 << 17, 1 << 20 };
const uint32_t last_blocks = 128;

template <int DIM> void find_seeds(call &c, const star_build &w)
{
    fill(c, w.seed, 0, 4);
    for (int found = 1; found <= DIM; found++) {
        launch(c, "seeds", seed_kernel<DIM>, at_most(1024, over(w.all.count, 256)), w.all, found, w.seed);
    }
}

/* Builds stars by a kernel of a later rung, in at most `blocks` blocks.  Returns how many it leaves in a.failed. */
template <typename RUNG, typename STAR, typename LAUNCH>
uint32_t run_rung(call &c, void (*kernel)(LAUNCH), LAUNCH a, uint32_t blocks)
{
    buffer<STAR> scratch(c);
    buffer<pbw__digit> pool(c);
    if (a.total == 0) {
        return 0;
    }
    blocks = !RUNG::shared ? last_blocks : blocks;
    blocks = a.total < blocks ? a.total : blocks;
    if (!RUNG::shared) {
        scratch.make(blocks);
        pool.make((size_t)blocks * 32 * PBW__POOL);
    }
    a.scratch = scratch.at;
    a.pool = pool.at;
    fill(c, a.w.next, 0, 1);
    fill(c, a.failed.count, 0, 1);
    launch(c, "stars", kernel, shape{ blocks, 32 * RUNG::warps, RUNG::shared ? sizeof(STAR) : 0 }, a);
    keep_points(c);
    return read_back(c, a.failed.count, PBW_STAGE_BUILD, 0.8);
}

/* Builds stars of q[from] by the second or third rung, with at most cap steps each, until more than limit fail.
   Returns how many it leaves in q[1 - from]. */
template <int DIM, bool WEIGHTED, typename RUNG>
uint32_t run_far_rung(call &c, const star_build &w, int from, uint32_t total, uint32_t limit, int cap)
{
    const rung_launch a = { w, w.q[from].vertex, total, limit, cap, NULL, NULL, w.q[1 - from] };
    return run_rung<RUNG, far_star<DIM, WEIGHTED, RUNG> >(c, far_kernel<DIM, WEIGHTED, RUNG>, a, total);
}

/* How many stars may need more than the second rung. */
uint32_t far_limit(const star_build &w)
{
    return 128 + w.out.size() / 2048;
}

/* Builds the stars in q[0], `left` of them, by the second rung, at first without exact tests, and the third; the few
   that the third fails come again with a larger cap. */
template <int DIM, bool WEIGHTED> void build_far_stars(call &c, const star_build &w, uint32_t left)
{
    left = run_far_rung<DIM, WEIGHTED, quick_rung>(c, w, 0, left, none, quick_cap);
    if (left > 0) {
        find_seeds<DIM>(c, w);
    }
    left = run_far_rung<DIM, WEIGHTED, far_rung>(c, w, 1, left, far_limit(w), far_cap);
    c.mesh->stars[2] = left;
    decline_above(c, left, far_limit(w));
    left = run_far_rung<DIM, WEIGHTED, last_rung>(c, w, 0, left, last_blocks, last_cap[0]);
    if (left <= last_blocks) {
        left = run_far_rung<DIM, WEIGHTED, last_rung>(c, w, 1, left, 0, last_cap[1]);
    }
    record_mark(c, 4);
    decline_above(c, left, 0);
}

/* ------------------------------------------------------------------------------------------------------
   >>wide         The rungs for points on surfaces: all simplices of a star search at once.
   In: as >>far.  Out: as >>far.

   Where points lie on a surface most spheres are large and follow it closely.  A box along the axes of space meets
   them wherever the surface is aslant, and a search for each simplex alone tests the same boxes again and again.  So
   here one search serves all simplices of a star, in a tree of OBBs: oriented bounding boxes, along the axes of their
   own points, and on a surface as thin as its noise.

   Let m be the middle of an OBB relative to v, e_j its axes, h_j the largest distance
   of its points from m along them, and g = q - 2m.  A point m + y of the OBB is in conflict with a simplex only if
   this is above 0:

       q . (m + y) - |m + y|^2 = q . m - |m|^2 + g . y - |y|^2
                              <= q . m - |m|^2 + sum over axes of t (|g . e_j| - t),     t = min(|g . e_j| / 2, h_j).

   Errors, with f = 2^-24 and B the sum of all |m_k| and h_j, which no point of the OBB is farther away than: q is
   off by 16 f Q; m, rounded to floats, by f |m|; two axes are those of Jacobi's method, rounded, the third is their
   cross product: for y that counts like axes of length 1, at right angles, that are off by 8 f; products and sums,
   10 f.  In all that is less than 40 f (Q B + B^2), and 48 f = 3 2^-20 is taken.  For infinite simplices |m|^2 and
   |y|^2 do not count (>>sphere).

   The depth of a point p in a sphere is the value above over Q |p|^2.  It tells how much larger the curvature is of
   the sphere through v and p with its centre in the direction of q.  So the deepest points make the star small
   soonest, and the OBBs that may have the deepest are searched first.
   ------------------------------------------------------------------------------------------------------ */
/* A box along the axes of its points, of 8 points or 8 boxes: its middle, two of its axes (the third is their cross
   product), and how far points are from the middle along each axis; all in units. */
struct alignas(16) obb {
    double middle[3];
    float axis[2][3], half[3], unused;
};

struct moments {                                     /* of the points of an OBB; spread: around the mean */
    double mean[3], spread[3][3];
};

const int obb_levels = 9;
typedef tree_of<obb, obb_levels> obb_tree;

/* The OBBs of a level, of 8 points or of 8 OBBs, but for half, which half_kernel adds. */
__global__ void obb_kernel(const __grid_constant__ space s, const moments *child, uint32_t children, moments *own,
                             obb *out, uint32_t size)
{
    size_t g = thread_number();
    if (g < size) {
        const uint32_t first = (uint32_t)g * 8, end = children - first < 8 ? children : first + 8;
        const double part = 1.0 / (double)(end - first);
        moments m = {};
        double turn[3][3] = { { 1.0, 0.0, 0.0 }, { 0.0, 1.0, 0.0 }, { 0.0, 0.0, 1.0 } };
        double(&a)[3][3] = m.spread;
        obb b = {};
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
            auto rotate = [&](double &x, double &y) {
                const double old = x;
                x = cosine * old - sine * y;
                y = sine * old + cosine * y;
            };
            for (int k = 0; k < 3; k++) {
                rotate(a[k][i], a[k][j]);
            }
            for (int k = 0; k < 3; k++) {
                rotate(a[i][k], a[j][k]);
                rotate(turn[i][k], turn[j][k]);
            }
        }
        for (int k = 0; k < 3; k++) {
            b.middle[k] = m.mean[k];
            b.axis[0][k] = (float)turn[0][k];
            b.axis[1][k] = (float)turn[1][k];
        }
        out[g] = b;
    }
}

/* Sets half of all OBBs, a thread a point. */
__global__ void half_kernel(const __grid_constant__ space s, const __grid_constant__ obb_tree t)
{
    const size_t i = thread_number() < s.count ? thread_number() : s.count - 1;
    const record r = s.point[i];
    size_t above = i / 8;
    for (int level = 0; level < t.levels; level++, above /= 8) {
        obb &b = ((obb *)t.level[level])[above];
        float last[3];
        double d[3] = { 0.0, 0.0, 0.0 };
        cross(b.axis[0], b.axis[1], last);
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

/* A star that is too large for a rung goes on to the next.  room: for OBBs that wait. */
template <int TRIANGLES, int BLOCKS, int ROOM, bool SHARED>
struct wide_rung_of : rung<TRIANGLES, 1, BLOCKS, true, SHARED> {
    static const int room = ROOM;
};
typedef wide_rung_of<128, 16, 448, true> wide_rung;
typedef wide_rung_of<512, 5, 1024, true> large_wide_rung;
typedef wide_rung_of<2048, 5, 8192, false> last_wide_rung;

const int group_room = 36;                           /* for groups, of which 4 are searched as soon as they wait */

template <typename RUNG> struct wide_star {
    typedef star<3, false, RUNG::triangles, RUNG::vertices, RUNG::room + group_room, rung_real<RUNG::exact> > type;
    type s;                                          /* scratch: OBBs that wait, levels << 28 | number; groups */
    float inverse[RUNG::triangles];                  /* 1 / Q, or 0: no point that matters is in conflict with it */
    uint16_t depth[RUNG::room];                      /* of OBBs that wait, half of a float */
};

/* Returns an upper bound of the depth of the points of an OBB in the spheres of a star. */
template <typename STAR> DEVICE float depth_of_obb(const STAR &w, int count, const obb &b, const double *v)
{
    float depth = 0.0f, m[3], last[3], ones = 0.0f, square_m = 1e-30f;
    for (int k = 0; k < 3; k++) {
        m[k] = (float)(b.middle[k] - v[k]);
        square_m = fmaf(m[k], m[k], square_m);
        ones += fabsf(m[k]) + b.half[k];
    }
    cross(b.axis[0], b.axis[1], last);
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

/* Returns an upper bound of the depth of a point. */
template <typename STAR> DEVICE float depth_of_place(const STAR &w, int count, const place<double> &p)
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

template <typename STAR> DEVICE void find_inverses(STAR &w, int count)
{
    for (int t = (int)threadIdx.x & 31; t < count; t += 32) {
        const float size = w.s.sphere[t].w;
        w.inverse[t] = size < 0.0f || (w.s.triangle[t] & verified) != 0 ? 0.0f : size < 1e35f ? 1.0f / size : 1.0f;
    }
    __syncwarp();
}

/* Returns for each 8 lanes the deepest of a quarter of the OBBs that wait, as depth << 16 | index, or 0.  If little
   room is left it returns the last ones: they are of low levels, so they add few more. */
template <typename RUNG> DEVICE uint32_t deepest(const wide_star<RUNG> &w, int waits)
{
    const int lane = (int)threadIdx.x & 31;
    uint32_t best = 0;
    if (waits > RUNG::room - 32 * (obb_levels + 1)) {
        return 1u << 16 | (uint32_t)(waits - 1 - lane / 8);
    }
    for (int i = (lane & 7) * 4 + lane / 8; i < waits; i += 32) {
        const uint32_t key = (uint32_t)w.depth[i] << 16 | (uint32_t)i;
        best = key > best ? key : best;
    }
    return tile_max<8>(best);
}

/* A launch of a rung for surfaces: for the listed vertices or, without a list, each stride-th of the part. */
struct wide_launch : rung_launch {
    obb_tree obbs;
    store in;                                        /* what earlier rungs have made */
    uint32_t stride;
    unsigned long long *steps;                       /* the sum over all stars, or NULL */
    long long cycles;                                /* a star that takes longer is lost; 0: no limit */
};

/* A star of these rungs while its warp builds it. */
template <typename RUNG> struct wide_state {
    wide_star<RUNG> &w;
    const wide_launch &a;
    uint32_t *waiting, *group;                       /* OBBs and groups that wait */
    site at;
    int lane, count, waits, groups;
    point_of<typename wide_star<RUNG>::type> candidate;              /* of each lane */
    float deep;                                      /* how deep it lies */
    unsigned pending;                                /* lanes with a candidate to insert */
};

/* Measures how deep the candidates of some lanes lie; those in conflict with no simplex go. */
template <typename RUNG> DEVICE void screen_candidates(wide_state<RUNG> &n, unsigned lanes)
{
    n.deep = (lanes >> n.lane & 1) != 0 ? depth_of_place(n.w, n.count, n.candidate.p) : 0.0f;
    n.pending = __ballot_sync(all_lanes, n.deep > 0.0f);
}

/* Starts with the star of v in the store, or else from points on the curve; all OBBs of the top level wait.
   Returns whether there is a star. */
template <typename RUNG> DEVICE bool start_wide(wide_state<RUNG> &n)
{
    typename wide_star<RUNG>::type &s = n.w.s;
    bool started = n.a.in.place[n.at.v - n.a.in.first] != none;
    unsigned candidates = 0;
    if (started) {
        n.count = start_from_store(s, n.at, n.a.in);
    } else {
        started = start_on_curve<true>(s, n.at, n.a.w.seed, n.candidate, n.count);
        candidates = started ? __ballot_sync(all_lanes, n.candidate.id != none) : 0;
    }
    if (n.lane < n.waits) {
        n.waiting[n.lane] = (uint32_t)n.a.obbs.levels << 28 | (uint32_t)n.lane;
        n.w.depth[n.lane] = 0x7f00;
    }
    find_inverses(n.w, n.count);
    if (candidates != 0) {
        screen_candidates(n, candidates);
    }
    return started;
}

/* Tests the points of 4 groups. */
template <typename RUNG> DEVICE void search_groups(wide_state<RUNG> &n)
{
    const int take = n.groups < 4 ? n.groups : 4;
    uint32_t id = n.lane / 8 < take ? n.group[n.groups - 1 - n.lane / 8] * 8 + (uint32_t)(n.lane & 7) : none;
    id = id < n.a.w.all.count && id != n.at.v ? id : none;
    n.groups -= take;
    __syncwarp();
    n.candidate = candidate_at<typename wide_star<RUNG>::type>(n.at, n.at.all->point[n.at.v], id);
    screen_candidates(n, __ballot_sync(all_lanes, id != none));
}

/* Removes up to 4 OBBs from those that wait, at an index for each 8 lanes: the last ones move there. */
template <typename RUNG> DEVICE void take_obbs(wide_state<RUNG> &n, int at)
{
    for (int k = 0; k < 4; k++) {
        const int most = warp_max<8>(at);
        n.waits -= most >= 0;
        if (most >= 0 && n.lane == 0) {
            n.waiting[most] = n.waiting[n.waits];
            n.w.depth[most] = n.w.depth[n.waits];
        }
        at = at == most ? -1 : at;
        __syncwarp();
    }
}

/* Tests the children of 4 OBBs. */
template <typename RUNG> DEVICE void search_obbs(wide_state<RUNG> &n)
{
    const obb_tree &obbs = n.a.obbs;
    const uint32_t best = deepest(n.w, n.waits);
    const int at = best != 0 ? (int)(best & 0xffff) : -1;
    const uint32_t node = at >= 0 ? n.waiting[at] : 0;
    const uint32_t level = (node >> 28) - 1, index = (node & 0xfffffff) * 8 + (uint32_t)(n.lane & 7);
    float may = 0.0f;
    if (at >= 0 && index < obbs.size[level]) {
        const record &own = n.at.all->point[n.at.v]; /* read again: few registers are left */
        const double origin[3] = { in_units(*n.at.all, own, 0), in_units(*n.at.all, own, 1),
                                   in_units(*n.at.all, own, 2) };
        may = depth_of_obb(n.w, n.count, obbs.level[level][index], origin);
    }
    __syncwarp();
    take_obbs(n, at);
    const int to = append<32>(may > 0.0f && level > 0, n.waits);
    const int to_group = append<32>(may > 0.0f && level == 0, n.groups);
    if (may > 0.0f && level > 0) {
        n.waiting[to] = level << 28 | index;
        n.w.depth[to] = (uint16_t)(__float_as_uint(fmaxf(may, 1e-30f)) >> 16);
    } else if (may > 0.0f) {
        n.group[to_group] = index;
    }
    __syncwarp();
}

/* Inserts the deepest of the candidates, unless it is a vertex: the search finds vertices too.  Returns whether the
   star stays within its room. */
template <typename RUNG> DEVICE bool insert_deepest(wide_state<RUNG> &n)
{
    const float most = tile_max<32>((n.pending >> n.lane & 1) != 0 ? n.deep : -1.0f);
    const int from = __ffs((int)(__ballot_sync(all_lanes, n.deep == most) & n.pending)) - 1;
    const point_of<typename wide_star<RUNG>::type> next = tile_read<32>(n.candidate, from);
    int count = n.count;
    const int result = is_vertex(n.w.s, next.id) ? 0 : insert(n.w.s, n.at, next, count);
    n.count = count;
    n.pending &= ~(1u << from);
    if (result == star_changed) {
        find_inverses(n.w, count);
    }
    if (result == star_changed && n.pending != 0) {
        n.deep = depth_of_place(n.w, count, n.candidate.p);
        n.pending &= __ballot_sync(all_lanes, n.deep > 0.0f);
    }
    return (result & ~star_changed) == 0;
}

/* Each warp builds a star, from that of an earlier rung on.  It searches the tree once: stars only shrink, so what is
   in conflict with no simplex now will never be.  When no OBB waits any more, the star is certified.  The deepest OBB
   is searched first, the deepest point inserted first. */
template <typename RUNG>
__global__ void __launch_bounds__(32 * RUNG::warps, RUNG::blocks) wide_kernel(const __grid_constant__ wide_launch a)
{
    const int lane = (int)threadIdx.x;
    extern __shared__ float4 shared_words[];
    wide_star<RUNG> &w = RUNG::shared ? *(wide_star<RUNG> *)shared_words : ((wide_star<RUNG> *)a.scratch)[blockIdx.x];
    pbw__digit *digits = a.pool == NULL ? NULL : a.pool + (blockIdx.x * 32 + (uint32_t)lane) * (size_t)PBW__POOL;
    for (;;) {
        uint32_t i = lane == 0 ? atomicAdd(a.w.next, 1u) : 0;
        i = __shfl_sync(all_lanes, i, 0);
        if (any(i >= a.total || *(volatile uint32_t *)a.failed.count > a.limit || *a.w.out.stop != 0)) {
            return;
        }
        const uint32_t v = a.vertex == NULL ? a.w.out.first + i * a.stride : a.vertex[i];
        wide_state<RUNG> n = { w, a, w.s.scratch, w.s.scratch + RUNG::room,
                               { &a.w.all, v, walls_of<3>(a.w.all, a.w.all.point[v]), digits },
                               lane, 0, 4, 0, { none, {} }, 0.0f, 0 };
        const long long start = a.cycles > 0 ? clock64() : 0;
        const bool started = start_wide(n);
        bool lost = !started;
        int spent = 0;
        while (!lost && (n.pending != 0 || n.waits > 0 || n.groups > 0)) {
            spent++;
            if (n.pending != 0) {
                lost = !insert_deepest(n);
            } else if (n.groups >= 4 || n.waits == 0) {
                search_groups(n);
            } else {
                search_obbs(n);
            }
            lost = lost || spent > a.cap || ((spent & 63) == 0 && any(*a.w.out.stop != 0))
                || (a.cycles > 0 && any(clock64() - start > a.cycles));
        }
        if (a.steps != NULL && lane == 0) {
            atomicAdd(a.steps, (unsigned long long)spent);
        }
        finish<32>(w.s, started, v, n.count, a.w.out);
        enqueue(a.failed, lane == 0 && lost, v);
        enqueue(a.w.q[2], lane == 0 && !lost && n.count > small_triangles - 4, v);
    }
}

/* Steps for a star of a sample on the rungs for surfaces: the cap, and the largest average that is not declined.
   With exact tests, as of cospherical points, a step takes 100 times as long: so cycles have a cap, too, 3 ms. */
const int sample_cap = 384;
const unsigned long long most_steps = 128;
const long long sample_cycles = 6000000;

/* Builds the tree of OBBs, one level after another, in an array that is large enough for all. */
obb_tree build_obb_tree(call &c, const space &s, obb *room)
{
    obb_tree t = {};
    buffer<moments> child(c);
    for (uint32_t size = s.count; t.levels == 0 || size > 32; t.levels++) {
        const uint32_t children = size;
        size = (size + 7) / 8;
        buffer<moments> own(c, size);
        launch(c, "oriented boxes", obb_kernel, over(size, 128), s, child.at, children, own.at, room, size);
        child = std::move(own);
        t.level[t.levels] = room;
        t.size[t.levels] = size;
        room += size;
    }
    launch(c, "oriented boxes", half_kernel, over(s.count, 256), s, t);
    return t;
}

/* Builds stars by a rung for surfaces, as run_far_rung does; returns how many it leaves. */
template <typename RUNG> uint32_t run_wide_rung(call &c, wide_launch &a, uint32_t total, uint32_t limit, int cap)
{
    a.total = total;
    a.limit = limit;
    a.cap = cap;
    const unsigned processors = (unsigned)processors_of(c, c.team->offers[c.card].device);
    return run_rung<RUNG, wide_star<RUNG> >(c, wide_kernel<RUNG>, a, processors * RUNG::blocks);
}

/* Returns whether a sample shows that few stars are large or need many steps.  The CPU takes 150 to 250 ns a point on
   16 threads; 4 warps a multiprocessor take 3 us each for a step. */
bool sample_stays_cheap(call &c, wide_launch a)
{
    a.stride = a.w.out.size() / sample_size;
    a.steps = a.w.seed + 4;
    a.cycles = sample_cycles;
    clear_stars(c, a.w);
    launch_near<3, false, false>(c, a.w, a.w.out.first, a.stride, sample_size, true);
    fill(c, a.steps, 0, 1);
    const uint32_t failed = run_wide_rung<wide_rung>(c, a, sample_size, none, sample_cap);
    const unsigned long long steps = read_back(c, a.steps, PBW_STAGE_BUILD, 0.1);
    return failed <= sample_size / 64 && steps <= most_steps * sample_size;
}

/* Stars that the first rung for surfaces left in q[0]. */
void build_large_wide_stars(call &c, wide_launch a, uint32_t failed)
{
    a.in = a.w.out;
    a.vertex = a.w.q[0].vertex;
    a.failed = a.w.q[1];
    const uint32_t last = run_wide_rung<large_wide_rung>(c, a, failed, far_limit(a.w), far_cap);
    decline_above(c, last, far_limit(a.w));          /* above its limit a rung leaves stars untried, uncounted */
    a.vertex = a.w.q[1].vertex;
    a.failed = a.w.q[0];
    failed = run_wide_rung<last_wide_rung>(c, a, last, 0, last_cap[0]);
    c.mesh->stars[2] = last;
    record_mark(c, 4);
    decline_above(c, failed, 0);
}

/* Builds the stars of points on surfaces; returns false if a sample shows that they would take too long.  The stars
   that the first rung begins are in a store of their own, which is freed. */
bool build_wide_stars(call &c, star_build &w, const obb_tree &obbs)
{
    const uint32_t mine = w.out.size(), limit = 128 + mine / 16;
    const unsigned long long enough = (unsigned long long)mine * 15 + 4096;
    wide_launch a = { { w, NULL, 0, 0, 0, NULL, NULL, w.q[0] }, obbs, w.out, 1, NULL, 0 };
    find_seeds<3>(c, w);
    if (!sample_stays_cheap(c, a)) {
        return false;
    }
    clear_stars(c, w);
    launch_near<3, false, false>(c, w, w.out.first, 1, mine, true);
    record_mark(c, 3);
    if (read_back(c, w.out.used, PBW_STAGE_BUILD, 0.2) > w.out.capacity) {
        return true;
    }
    w.out.capacity = w.out.capacity > enough ? w.out.capacity : enough;
    fill(c, w.out.used, 0, 1);
    w.out.word = allocate<uint32_t>(c, (size_t)w.out.capacity * 4);
    a.w = w;
    const uint32_t failed = run_wide_rung<wide_rung>(c, a, mine, limit, quick_cap);
    const unsigned long long used = read_back(c, w.out.used, PBW_STAGE_BUILD, 0.8);
    release(c, a.in.word);
    if (used > w.out.capacity) {
        return true;
    }
    c.mesh->stars[0] = c.mesh->stars[1] = mine;
    decline_above(c, failed, limit);
    build_large_wide_stars(c, a, failed);
    return true;
}

/* ------------------------------------------------------------------------------------------------------
   >>stars        All stars of a card: its part of the points, memory, the choice of rungs.
   In: the points in order.  Out: the store with the stars of the part.
   Holds: when the store is used, it has the star of every vertex of the part that is not hidden; else the call fails.
   ------------------------------------------------------------------------------------------------------ */
/* Sets the part of a card: whole groups, in proportion to its multiprocessors. */
void set_part(call &c, star_build &w)
{
    const int cards = c.team->count;
    double before[most_cards + 1] = { 0.0 };
    for (int i = 0; i < cards; i++) {
        before[i + 1] = before[i] + processors_of(c, c.team->offers[i].device);
    }
    auto first_of = [&](int card) {
        const double all = (double)w.all.count * (before[card] / before[cards]);
        return card == cards ? w.all.count : (uint32_t)all / group_size * group_size;
    };
    w.out.first = first_of(c.card);
    w.out.end = first_of(c.card + 1);
    c.stars = w.out.size();
}

/* Shares the points, grows the tree, and allocates what the rungs need. */
void open_star_build(call &c, star_build &w, int dim)
{
    set_part(c, w);
    const uint32_t mine = w.out.size(), groups = (mine + group_size - 1) / group_size;
    w.out.capacity = (unsigned long long)mine * (dim == 3 ? 13 : 5) + 4096;
    /* rough points and boxes; the store, queues, places and counts; lists and their heads of 8 points */
    need_memory(c, (size_t)w.all.count * 16 + (size_t)w.all.count / group_size * sizeof(box)
                   + (size_t)w.out.capacity * 16 + (size_t)mine * (12 + 8)
                   + (size_t)groups * (list_size * 4 + sizeof(near_list)));
    build_tree(c, w.all, dim, w.boxes);
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
        copies_follow(c);
        c.stop = counts + 4;
    }
    launch(c, "lists", list_kernel, over((size_t)groups * 32, 128), w.boxes, dim, w.out.first / group_size,
           w.out.first / group_size + groups, w.lists, w.infos);
}

template <int DIM, bool WEIGHTED> void build_stars(call &c, star_build &w)
{
    /* weights hide points, which is quick: no sample */
    const bool sampled = !WEIGHTED && !pbw_cuda_patient && w.all.count >= sampled_from
                      && w.out.size() >= sample_size;
    const bool far = sampled && sample_reaches_far<DIM, WEIGHTED>(c, w);
    if (far && DIM == 3) {
        buffer<obb> obbs(c, w.all.count / 7 + 2 * obb_levels);
        if (build_wide_stars(c, w, build_obb_tree(c, w.all, obbs.at))) {
            return;
        }
    }
    decline_unless(c, !far || c.no_cpu,
                   "most stars reach far (points on lines, or nearly in a plane?): quicker on the CPU");
    const uint32_t left = build_near_stars<DIM, WEIGHTED>(c, w);
    c.mesh->stars[1] = left;
    build_far_stars<DIM, WEIGHTED>(c, w, left);
}

/* Builds all stars, once more if the store turns out too small. */
template <int DIM, bool WEIGHTED> void fill_store(call &c, star_build &w)
{
    unsigned long long used = w.out.capacity;
    record_mark(c, 2);
    do {
        release(c, w.out.word);
        w.out.capacity = used > w.out.capacity ? used + used / 16 : used;
        w.out.word = allocate<uint32_t>(c, (size_t)w.out.capacity * 4);
        build_stars<DIM, WEIGHTED>(c, w);
        used = read_back(c, w.out.used, PBW_STAGE_BUILD, 0.95);
    } while (used > w.out.capacity);
    release(c, w.lists);
    release(c, w.infos);
    require(c, used <= ((unsigned long long)1 << 32) - 16, PBW_ERROR_TOO_LARGE, too_many);
}

/* ------------------------------------------------------------------------------------------------------
   >>cards        Copies between the cards of a job.
   In: an offer of another card, complete.  Out: a copy on this one: directly where the devices reach each other, else
   by way of the host.
   ------------------------------------------------------------------------------------------------------ */
/* Gives the other devices that can read this one access to its pool: copies then go directly. */
void open_pool(call &c)
{
    offer &own = c.team->offers[c.card];
    cudaMemPool_t pool;
    need(c, cudaDeviceGetMemPool(&pool, own.device), "cudaDeviceGetMemPool");
    for (int i = 0; i < c.team->count; i++) {
        const int other = c.team->offers[i].device;
        int can = other != own.device;
        if (can) {
            need(c, cudaDeviceCanAccessPeer(&can, other, own.device), "cudaDeviceCanAccessPeer");
        }
        if (can) {
            cudaMemAccessDesc access = { { cudaMemLocationTypeDevice, other }, cudaMemAccessFlagsProtReadWrite };
            can = cudaMemPoolSetAccess(pool, &access, 1) == cudaSuccess;
            (void)cudaGetLastError();
        }
        own.open[i] = (can || other == own.device) && !pbw_cuda_by_host;
    }
}

/* Copies by way of the host from a card that this one cannot read; the offer is complete.  Pinned memory would be
   copied more quickly, but to pin it takes time, and to free it waits for all streams of the device.  From four cards
   on that costs more. */
void fetch_by_host(call &c, int card, char *to, const char *from, size_t bytes)
{
    const size_t most = (size_t)1 << 24;
    void *const host = malloc(bytes < most ? bytes : most);
    require(c, host != NULL, PBW_ERROR_MEMORY, no_host_memory);
    auto copy = [&](int on, void *target, const void *source, size_t part, cudaStream_t stream) {
        return good(c, cudaSetDevice(c.team->offers[on].device), "cudaSetDevice")
            && good(c, cudaMemcpyAsync(target, source, part, cudaMemcpyDefault, stream), "copying by the host")
            && good(c, cudaStreamSynchronize(stream), "copying by the host");
    };
    for (size_t at = 0; at < bytes && c.status == PBW_OK; at += most) {
        const size_t part = bytes - at < most ? bytes - at : most;
        copy(card, host, from + at, part, cudaStreamPerThread);
        copy(c.card, to + at, host, part, c.stream);
    }
    free(host);
    throw_if_failed(c);
}

template <typename V> void fetch_from(call &c, int card, V *to, const void *from, size_t count)
{
    const offer *offers = c.team->offers;
    const size_t bytes = count * sizeof(V);
    if (bytes > 0 && !offers[card].open[c.card]) {
        fetch_by_host(c, card, (char *)to, (const char *)from, bytes);
    } else if (bytes > 0) {
        need(c, cudaMemcpyPeerAsync(to, offers[c.card].device, from, offers[card].device, bytes, c.stream),
             "copying between devices");
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>cells        Simplices, neighbours, incident simplices.
   In: the store.  Out: the arrays on the device, and for a job of pbw.h also in its memory, copied while later stages
   run.

   A simplex is written by its lowest vertex, in the canonical form and order of >>output of pbw.h: the simplices of a
   vertex lie together, sorted by their second and third corner.  The star of a facet's lowest vertex has both sides
   of the facet, as two triangles with a common edge; the numbers of the two simplices are found by their corners.

   Several cards:
     1. Each writes the simplices that have their lowest vertex in its part.
     2. The stars of a part also have simplices with their lowest vertex in a lower part: the halo simplices of the
        part.  The lower cards, which write them, list them and their numbers, in the canonical order.
     3. Only one facet of a halo simplex can have its lowest vertex in the part: the one without the first corner of
        the simplex.  Its card finds the simplex across that facet.
     4. The lower cards fetch the numbers of these.
   ------------------------------------------------------------------------------------------------------ */
template <int DIM> struct alignas(DIM == 3 ? 16 : 4) cell {
    uint32_t corner[DIM + 1];
};

/* The canonical form of the positive simplex (v, a...): the lowest corner first; in space the lowest of the rest
   second, in the plane the others in cyclic order. */
template <int DIM> DEVICE cell<DIM> canonical(uint32_t v, const uint32_t *a)
{
    cell<DIM> c;
    c.corner[0] = v;
    for (int k = 0; k < DIM; k++) {
        c.corner[k + 1] = a[k];
    }
    for (int turn = DIM == 3 ? 0 : 3; turn < 5; turn++) {            /* of three corners: it stays positive */
        uint32_t *const p = c.corner + (DIM == 3 && turn != 2 ? 1 : 0);
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

/* The star of v; without triangles if it is hidden, or without go.  A null pointer would make all loads generic. */
DEVICE stored_star stored(const store &in, uint32_t v, bool go)
{
    const uint32_t at = go ? in.place[v - in.first] : hidden;
    const uint32_t *const word = in.word + (at != hidden ? (size_t)at * 4 : 0);
    const uint32_t head = at != hidden ? word[0] : 0;
    const int vertices = (int)(head & 0xffff);
    return { word + 1, word + 1 + vertices, (int)(head >> 16), vertices };
}

/* The vertices of a triangle; returns whether all are finite. */
template <int DIM> DEVICE bool triangle_of(const stored_star &s, int t, uint32_t *a)
{
    bool finite = true;
    for (int k = 0; k < DIM; k++) {
        a[k] = s.vertex[corner(s.triangle[t], k)];
        finite = finite && a[k] != none;
    }
    return finite;
}

/* Whether v comes before all vertices of a triangle, or all but the one at k. */
template <int DIM> DEVICE bool is_lowest(uint32_t v, const uint32_t *a, int k = -1)
{
    bool lowest = true;
    for (int i = 0; i < DIM; i++) {
        lowest = lowest && (i == k || a[i] > v);
    }
    return lowest;
}

template <int DIM> DEVICE uint64_t middle_corners(const cell<DIM> &c)
{
    return (uint64_t)c.corner[1] << 32 | c.corner[2];
}

/* The corners by other numbers. */
template <int DIM> DEVICE cell<DIM> renumbered(cell<DIM> c, const uint32_t *number)
{
    for (int k = 0; k <= DIM; k++) {
        c.corner[k] = number[c.corner[k]];
    }
    return c;
}

const int emit_block = 64;

/* The simplices of a part, in order, by ranks, and its halo simplices. */
template <int DIM> struct directory {
    uint32_t first, base, halo_count;                /* the first vertex; the number of the first simplex */
    const uint32_t *offset, *halo_numbers;           /* offset: where the simplices of each vertex begin */
    const cell<DIM> *cells, *halo;
};

/* Writes the simplices of a star by 8 lanes.  cells: by ranks, in order; out: first by ranks, as the triangles of the
   star come, then like cells, by the caller's ids. */
template <int DIM>
__global__ void emit_kernel(const __grid_constant__ store in, const uint32_t *offset, const uint32_t *id,
                            cell<DIM> *cells, cell<DIM> *out)
{
    const int T = 8;
    int lane = (int)threadIdx.x & (T - 1), found = 0;
    uint32_t v = in.first + (blockIdx.x * emit_block + threadIdx.x) / T;
    bool go = v < in.end;
    uint32_t owned = go ? in.owned[v - in.first] : 0, first = go ? offset[v - in.first] : 0;
    const stored_star s = stored(in, v, owned > 0);
    cells += first, out += first;
    for (int base = 0; any(base < s.count); base += T) {
        uint32_t a[3];
        const bool mine = base + lane < s.count && triangle_of<DIM>(s, base + lane, a) && is_lowest<DIM>(v, a);
        const int at = append<T>(mine, found);
        if (mine) {
            out[at] = canonical<DIM>(v, a);
        }
    }
    __syncwarp();
    for (int t = lane; t < found; t += T) {
        uint32_t before = 0;
        const cell<DIM> c = out[t];
        for (int i = 0; i < found; i++) {
            before += middle_corners(out[i]) < middle_corners(c);
        }
        cells[before] = c;
    }
    __syncwarp();
    for (int t = lane; t < found; t += T) {
        out[t] = renumbered(cells[t], id);
    }
}

/* Returns the last of the cells from low to high that does not come after c, by all but the last corner. */
template <int DIM> DEVICE uint32_t last_until(const cell<DIM> &c, const cell<DIM> *cells, uint32_t low, uint32_t high)
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
template <int DIM> DEVICE uint32_t number_of(const cell<DIM> &c, const directory<DIM> &all)
{
    if (c.corner[0] < all.first) {
        return all.halo_numbers[last_until<DIM>(c, all.halo, 0, all.halo_count)];
    }
    const uint32_t *offset = all.offset + (c.corner[0] - all.first);
    return all.base + last_until<DIM>(c, all.cells, offset[0], offset[1]);
}

/* Where links go.  neighbors: NULL if the caller wants none; across: for each halo simplex the one behind its facet;
   incident: by the caller's ids, or from the part's first vertex on if id is NULL. */
struct links {
    pbw_index *neighbors, *across, *incident;
    const uint32_t *id;
};

/* Writes the links of the star of v by T lanes: its lowest simplex, and the neighbours across facets that have v as
   their lowest vertex.  number(t): of the simplex on triangle t, or none; opposite(triangle, k): the triangle across
   from corner k of a packed one. */
template <int T, int DIM, typename F, typename G>
DEVICE void link_star(const directory<DIM> &all, const links &out, uint32_t v, const stored_star &s, F number,
                      G opposite)
{
    const int lane = (int)threadIdx.x & (T - 1);
    uint32_t lowest = none, a[3];
    for (int t = lane; t < s.count; t += T) {
        const uint32_t own = number(t), triangle = s.triangle[t];
        lowest = min(lowest, own);
        if (own == none || out.neighbors == NULL) {
            continue;
        }
        triangle_of<DIM>(s, t, a);
        const cell<DIM> c = canonical<DIM>(v, a);
#pragma unroll
        for (int k = 0; k < DIM; k++) {
            if (is_lowest<DIM>(v, a, k) && c.corner[0] < all.first) {
                out.across[last_until<DIM>(c, all.halo, 0, all.halo_count)] = number(opposite(triangle, k));
            } else if (is_lowest<DIM>(v, a, k)) {
                int at = 0;
                for (int i = 1; i <= DIM; i++) {
                    at = c.corner[i] == a[k] ? i : at;
                }
                out.neighbors[(size_t)(own - all.base) * (DIM + 1) + (size_t)at] = number(opposite(triangle, k));
            }
        }
    }
    lowest = tile_min<T>(lowest);
    if (s.count > 0 && lane == 0) {
        out.incident[out.id != NULL ? out.id[v] : v - all.first] = lowest;
    }
}

DEVICE bool is_small(const stored_star &s)
{
    return s.count <= small_triangles && s.vertices <= small_vertices;
}

/* Writes the links of the small stars, 8 lanes each, with a table of triangles.  3D: the triangle that has a directed
   edge; 2D: row 0 has the edge that begins at a vertex, row 1 the edge that ends there. */
template <int DIM>
__global__ void neighbor_kernel(const __grid_constant__ store in, const __grid_constant__ directory<DIM> all,
                                const __grid_constant__ links out, uint32_t *hidden_count)
{
    const int T = 8;
    __shared__ uint8_t shared_table[emit_block / T][small_vertices * small_vertices];
    __shared__ uint32_t shared_number[emit_block / T][small_triangles + 4];
    uint8_t *table = shared_table[threadIdx.x / T];
    uint32_t *number = shared_number[threadIdx.x / T];
    const int lane = (int)threadIdx.x & (T - 1);
    const uint32_t v = in.first + (blockIdx.x * emit_block + threadIdx.x) / T;
    stored_star s = stored(in, v, v < in.end);
    if (v < in.end && s.count == 0 && lane == 0) {
        atomicAdd(hidden_count, 1u);
    }
    s.count = is_small(s) ? s.count : 0;
    for (int t = lane; t < s.count; t += T) {
        uint32_t a[3];
        for (int k = 0; k < DIM; k++) {
            uint32_t from = corner(s.triangle[t], k), to = corner(s.triangle[t], k + 1 == DIM ? 0 : k + 1);
            table[DIM == 3 ? from * small_vertices + to : (uint32_t)k * small_vertices + from] = (uint8_t)t;
        }
        number[t] = triangle_of<DIM>(s, t, a) ? number_of<DIM>(canonical<DIM>(v, a), all) : none;
    }
    __syncwarp();
    link_star<T>(all, out, v, s, [&](int t) { return number[t]; }, [&](uint32_t triangle, int k) {
        uint32_t c[3] = { corner(triangle, 0), corner(triangle, 1), corner(triangle, 2) };
        uint32_t from = DIM == 3 ? c[(k + 2) % 3] : (uint32_t)k, to = DIM == 3 ? c[(k + 1) % 3] : c[1 - k];
        return table[from * small_vertices + to];
    });
}

/* Writes the links of the larger stars, a warp each, with a search for each triangle across an edge. */
template <int DIM>
__global__ void large_neighbor_kernel(queue large, const __grid_constant__ store in,
                                      const __grid_constant__ directory<DIM> all, const __grid_constant__ links out)
{
    const uint32_t i = blockIdx.x * (blockDim.x / 32) + threadIdx.x / 32;
    const uint32_t v = i < *large.count ? large.vertex[i] : in.end;
    const stored_star s = stored(in, v, v < in.end);
    if (is_small(s)) {
        return;
    }
    auto number = [&](int t) {
        uint32_t a[3];
        return t >= 0 && triangle_of<DIM>(s, t, a) ? number_of<DIM>(canonical<DIM>(v, a), all) : none;
    };
    auto opposite = [&](uint32_t triangle, int k) { return opposite_of<DIM>(s.triangle, s.count, triangle, k); };
    link_star<32>(all, out, v, s, number, opposite);
}

/* The halo simplices that one card has for another: the count of each vertex, and where they go. */
template <int DIM> struct halo_list {
    uint32_t *count;
    const uint32_t *place;
    cell<DIM> *halo;                                 /* NULL: they are only counted */
    uint32_t *number;
};

/* Lists the simplices of a part that have vertices of another, a thread a vertex. */
template <int DIM>
__global__ void halo_kernel(const __grid_constant__ directory<DIM> all, uint32_t vertices, range other,
                             const __grid_constant__ halo_list<DIM> out)
{
    size_t v = thread_number();
    uint32_t found = 0;
    for (uint32_t i = v < vertices ? all.offset[v] : 0; v < vertices && i < all.offset[v + 1]; i++) {
        cell<DIM> c = all.cells[i];
        bool visits = false;
        for (int k = 1; k <= DIM; k++) {
            visits = visits || other.has(c.corner[k]);
        }
        if (visits && out.halo != NULL) {
            out.halo[out.place[v] + found] = c;
            out.number[out.place[v] + found] = all.base + i;
        }
        found += visits;
    }
    if (v < vertices && out.halo == NULL) {
        out.count[v] = found;
    }
}

/* Writes the links that the card of another part has found for its halo simplices. */
template <int DIM>
__global__ void return_kernel(const __grid_constant__ directory<DIM> all, range other, uint32_t count,
                              const uint32_t *number, const pbw_index *across, pbw_index *neighbors)
{
    size_t i = thread_number();
    if (i < count) {
        uint32_t own = number[i] - all.base, second = none;
        cell<DIM> c = all.cells[own];
        for (int k = 1; k <= DIM; k++) {
            second = min(second, c.corner[k]);
        }
        if (other.has(second)) {
            neighbors[(size_t)own * (DIM + 1)] = across[i];
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

/* Copies results by the stream of copies, in parts, since memory that is not pinned makes the host wait for each. */
void copy_by_driver(call &c, const host_copy &copy)
{
    const size_t most = (size_t)1 << 25;
    need(c, cudaStreamWaitEvent(c.copies, copy.after, 0), "cudaStreamWaitEvent");
    for (size_t at = 0; at < copy.bytes; at += most) {
        need(c, cudaMemcpyAsync(copy.to + at, copy.from + at, std::min(most, copy.bytes - at), cudaMemcpyDeviceToHost,
                                c.copies), "copying results");
        poll(c, PBW_STAGE_OUTPUT, 0.4);
        throw_if_failed(c);
    }
}

/* Copies results to the host: at once to pinned memory, else by copy_later.  after: recorded when they are there, or
   NULL: when all work so far is done. */
void copy_out(call &c, void *to, const void *from, size_t bytes, cudaEvent_t after)
{
    host_copy copy = { (char *)to, (const char *)from, bytes, after };
    if (!is_pinned(to)) {
        c.later[c.laters++] = copy;
        return;
    }
    need(c, cudaEventRecord(c.ready[1], c.stream), "cudaEventRecord");
    copy.after = after != NULL ? after : c.ready[1];
    copy_by_driver(c, copy);
}

/* Copies what waits, when the device has all its work. */
void copy_later(call &c)
{
    need(c, cudaEventRecord(c.ready[1], c.stream), "cudaEventRecord");
    for (int i = 0; i < c.laters; i++) {
        c.later[i].after = c.later[i].after != NULL ? c.later[i].after : c.ready[1];
    }
    if (!copy_staged(c, c.later, c.laters, true, PBW_STAGE_OUTPUT)) {
        for (int i = 0; i < c.laters; i++) {
            copy_by_driver(c, c.later[i]);
        }
    }
}

/* Lists the halo simplices of higher cards that this one writes. */
template <int DIM> void list_halo(call &c, const directory<DIM> &all, uint32_t vertices)
{
    offer &own = c.team->offers[c.card];
    buffer<uint32_t> count(c, (size_t)vertices + 1), place(c, (size_t)vertices + 1);
    fill(c, count.at + vertices, 0, 1);
    for (int i = c.card + 1; i < c.team->count; i++) {
        const range part = c.team->offers[i].part;
        halo_list<DIM> list = { count.at, place.at, NULL, NULL };
        launch(c, "halo simplices", halo_kernel<DIM>, over(vertices, 128), all, vertices, part, list);
        sum_before(c, count.at, place.at, (size_t)vertices + 1);
        own.halo_count[i] = read_back(c, place.at + vertices, PBW_STAGE_OUTPUT, 0.2);
        own.halo[i] = list.halo = allocate<cell<DIM> >(c, own.halo_count[i]);
        own.halo_numbers[i] = list.number = allocate<uint32_t>(c, own.halo_count[i]);
        launch(c, "halo simplices", halo_kernel<DIM>, over(vertices, 128), all, vertices, part, list);
    }
    wait(c, PBW_STAGE_OUTPUT, 0.2);
}

/* Fetches the halo simplices of this card from the lower ones. */
template <int DIM> void fetch_halo(call &c, directory<DIM> &all)
{
    const offer *offers = c.team->offers;
    size_t count = 0;
    for (int i = 0; i < c.card; i++) {
        count += offers[i].halo_count[c.card];
    }
    cell<DIM> *const halo = allocate<cell<DIM> >(c, count);
    uint32_t *const number = allocate<uint32_t>(c, count);
    pbw_index *const across = c.team->offers[c.card].across = allocate<pbw_index>(c, count);
    fill(c, across, 0xff, count);                    /* some are copied and never read: those without a facet here */
    all.halo = halo;
    all.halo_numbers = number;
    for (int i = 0; i < c.card; i++) {
        const uint32_t some = offers[i].halo_count[c.card];
        fetch_from(c, i, halo + all.halo_count, offers[i].halo[c.card], some);
        fetch_from(c, i, number + all.halo_count, offers[i].halo_numbers[c.card], some);
        all.halo_count += some;
    }
}

/* Fetches the links that higher cards have found for the simplices of this one. */
template <int DIM> void fetch_across(call &c, const directory<DIM> &all, pbw_index *neighbors)
{
    const offer *offers = c.team->offers;
    for (int i = c.card + 1; i < c.team->count; i++) {
        const uint32_t count = offers[c.card].halo_count[i];
        size_t before = 0;
        buffer<pbw_index> across(c, count);
        for (int k = 0; k < c.card; k++) {
            before += offers[k].halo_count[i];
        }
        fetch_from(c, i, across.at, offers[i].across + before, count);
        launch(c, "neighbours", return_kernel<DIM>, over(count, 128), all, offers[i].part, count,
               offers[c.card].halo_numbers[i], across.at, neighbors);
    }
}

/* Where the simplices of a part go. */
struct output {
    const uint32_t *id;
    bool alone, with_neighbors, to_host;
    uint32_t *offset, total;                         /* of each vertex; of the part */
    size_t before;                                   /* simplices of lower parts */
};

void number_simplices(call &c, const star_build &w, output &o)
{
    const uint32_t mine = w.out.size();
    o.offset = allocate<uint32_t>(c, (size_t)mine + 1);
    sum_before(c, w.out.owned, o.offset, (size_t)mine + 1);
    o.total = read_back(c, o.offset + mine, PBW_STAGE_OUTPUT, 0.0);
    c.team->offers[c.card].part = w.out;
    c.team->offers[c.card].simplices = o.total;
    wait_for_cards(c, false, 0.0);
    for (int i = 0; i < c.team->count; i++) {
        o.before += i < c.card ? c.team->offers[i].simplices : 0;
        c.mesh->simplex_count += c.team->offers[i].simplices;
    }
    record_mark(c, 5);
    require(c, c.mesh->simplex_count < hidden, PBW_ERROR_TOO_LARGE, too_many);
}

/* Writes the simplices, and lists those that other cards need. */
template <int DIM> void emit_simplices(call &c, const star_build &w, const output &o, directory<DIM> &all)
{
    const uint32_t mine = w.out.size();
    pbw_cuda_mesh *const mesh = c.mesh;
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
    record_mark(c, 6);
    all = { w.out.first, (uint32_t)o.before, 0, o.offset, NULL, cells, NULL };
    pbw_status status = o.to_host && c.card == 0 ? c.job->reserve(c.job, mesh->simplex_count) : PBW_OK;
    require(c, status == PBW_OK, status, no_host_memory);
    if (!o.alone) {
        list_halo<DIM>(c, all, mine);
        wait_for_cards(c, false, 0.1);
        fetch_halo<DIM>(c, all);
    }
    if (o.to_host) {
        copy_out(c, c.job->simplices + o.before * (DIM + 1), mesh->simplices, links * sizeof(pbw_index),
                 c.mark[6]);
    }
}

/* Finds the neighbours and incident simplices; w.next counts hidden points. */
template <int DIM> void find_neighbors(call &c, const star_build &w, const output &o, const directory<DIM> &all)
{
    const links out = { c.mesh->neighbors, o.alone ? NULL : c.team->offers[c.card].across, c.mesh->incident,
                        o.alone ? o.id : NULL };
    const shape tiles = over((size_t)w.out.size() * 8, emit_block);
    launch(c, "neighbours", neighbor_kernel<DIM>, tiles, w.out, all, out, w.next);
    if (c.mesh->stars[1] > 0) {
        const shape warps = over(c.mesh->stars[1] * 32, 128);
        launch(c, "neighbours", large_neighbor_kernel<DIM>, warps, w.q[2], w.out, all, out);
    }
    record_mark(c, 7);
    if (!o.alone) {
        c.team->offers[c.card].incident = c.mesh->incident;
        wait(c, PBW_STAGE_OUTPUT, 0.2);
        wait_for_cards(c, false, 0.3);
    }
    if (!o.alone && o.with_neighbors) {
        fetch_across<DIM>(c, all, c.mesh->neighbors);
    }
    if (o.to_host && o.with_neighbors) {
        copy_out(c, c.job->neighbors + o.before * (DIM + 1), c.mesh->neighbors,
                 (size_t)o.total * (DIM + 1) * sizeof(pbw_index), NULL);
    }
}

/* Writes the arrays of points: the first card the incident simplices of all, the last card the canonical points. */
void copy_points(call &c, const output &o)
{
    pbw_index *incident = c.mesh->incident;
    const size_t bytes = c.count * sizeof(pbw_index);
    if (!o.alone && c.card == 0) {
        incident = allocate<pbw_index>(c, c.count);
        fill(c, incident, 0xff, c.count);
    }
    for (int i = 0; !o.alone && c.card == 0 && i < c.team->count; i++) {
        const range part = c.team->offers[i].part;
        buffer<pbw_index> some(c, part.size());
        fetch_from(c, i, some.at, c.team->offers[i].incident, part.size());
        launch(c, "incident simplices", scatter_kernel, over(part.size(), 256), o.id + part.first, part.size(),
               some.at, incident);
    }
    if (o.to_host && c.card == 0) {
        copy_out(c, c.job->incident, incident, bytes, NULL);
    }
    if (o.to_host && c.card + 1 == c.team->count) {
        copy_out(c, c.job->canonical, c.mesh->canonical, bytes, NULL);
    }
}

template <int DIM, bool WEIGHTED> void build(call &c, const space &s, const uint32_t *id, unsigned flags)
{
    output o = { id, c.team->count == 1, (flags & PBW_NO_NEIGHBORS) == 0, c.job->reserve != NULL, NULL, 0, 0 };
    star_build w = {};
    directory<DIM> all = {};
    w.all = s;
    open_star_build(c, w, DIM);
    fill_store<DIM, WEIGHTED>(c, w);
    number_simplices(c, w, o);
    emit_simplices<DIM>(c, w, o, all);
    find_neighbors<DIM>(c, w, o, all);
    copy_points(c, o);
    copy_later(c);
    c.mesh->hidden_count = read_back(c, w.next, PBW_STAGE_OUTPUT, 0.5);
}

/* ------------------------------------------------------------------------------------------------------
   >>check        The exact verdict on a mesh.
   In: points and the arrays of a mesh.  Out: the first fault of the first pass that has one, and counts.

   The tests are those of pbw_check, in its order (>>faults of pbw.h), but for one: two hidden points with the same
   coordinates are not found.  The passes: points, simplices, hull, hidden points; a thread an item.  If the stages
   without memory leave an item open, it is listed, and tested again by a thread that has a pool.
   ------------------------------------------------------------------------------------------------------ */
enum { check_points, check_simplices, check_hull, check_hidden, check_passes };

struct view : pbwck__tested {
    const uint32_t *order;                           /* points along the curve, or NULL */
};

struct check_result {
    unsigned long long least;                        /* item of the first fault << 32 | fault */
    unsigned long long counted[check_passes][3];
    uint32_t open;                                   /* items listed */
    pbwck__finding first;
};

__global__ void record_kernel(input in, double *record)
{
    size_t i = thread_number();
    if (i < in.count) {
        fetch(in, i, record + i * (size_t)(in.dim + 1));
    }
}

/* Tests the ridges of the hull facets of a simplex. */
template <int DIM> __device__ int test_ridges(const view &m, uint32_t s, pbwck__finding *found)
{
    for (int i = 0; i <= DIM; i++) {
        for (int k = 0; k <= DIM && m.neighbors[(size_t)s * (DIM + 1) + (size_t)i] == none; k++) {
            pbwck__turn turn = { s, i, k };
            while (k != i && pbwck__turn_on(&m, DIM, &turn)) {
            }
            if (k != i && !pbwck__test_ridge(&m, DIM, s, i, &turn, found)) {
                return 0;
            }
        }
    }
    return 1;
}

/* Returns a simplex near the point of a rank: one of a vertex before it on the curve. */
DEVICE uint32_t simplex_near(const view &m, uint32_t rank)
{
    uint32_t found = none;
    for (int tries = 0; tries < 64 && rank > 0 && found == none; tries++) {
        found = m.incident[m.order[--rank]];
    }
    return found != none ? found : 0;
}

/* Tests a point, if it is neither a vertex nor a duplicate; with an order, the item is a rank. */
template <int DIM> __device__ int test_hidden(const view &m, uint32_t item, pbwck__finding *found)
{
    const uint32_t point = m.order != NULL ? m.order[item] : item;
    if (m.canonical[point] != point || m.incident[point] != none) {
        return 1;
    }
    const uint32_t start = m.order != NULL ? simplex_near(m, item) : 0;
    pbwck__visit visit = { point, start, start };
    while (pbwck__visit_on(&m, DIM, &visit, found)) {
    }
    return pbwck__test_visited(&m, DIM, &visit, found);
}

const unsigned check_blocks = 64;                    /* of 32 threads that have pools */

/* Tests count items, all or those of a list, one thread each or in turn, up to the first known fault.  The fault of a
   single item is described. */
struct check_launch {
    view m;
    int pass;
    uint32_t count;
    const uint32_t *list;
    uint32_t *open;
    pbw__digit *pool;
    check_result *out;
};

template <int DIM> __global__ void check_kernel(const __grid_constant__ check_launch a)
{
    const view &m = a.m;
    const size_t thread = thread_number(), threads = (size_t)gridDim.x * blockDim.x;
    pbw__digit *const own_pool = a.pool != NULL ? a.pool + thread * PBW__POOL : NULL;
    unsigned long long counted[3] = { 0, 0, 0 };     /* by sound items: an open one comes again */
    for (size_t i = thread; i < a.count; i += threads) {
        pbwck__finding found = { own_pool, PBWCK__SOUND, -1, none, none, { 0, 0, 0 } };
        uint32_t item = a.list == NULL ? (uint32_t)i : a.list[i];
        if (a.count > 1 && *(const volatile unsigned long long *)&a.out->least >> 32 < item) {
            continue;
        }
        int sound = a.pass == check_points ? pbwck__test_point(&m, DIM, item, &found)
                  : a.pass == check_simplices ? pbwck__test_simplex(&m, DIM, item, &found)
                  : a.pass == check_hull ? test_ridges<DIM>(m, item, &found) : test_hidden<DIM>(m, item, &found);
        if (!sound && found.fault == PBWCK__FAULT_OPEN) {
            a.open[atomicAdd(&a.out->open, 1u)] = item;
        } else if (!sound) {
            atomicMin(&a.out->least, (unsigned long long)item << 32 | (unsigned)found.fault);
            if (a.count == 1) {
                a.out->first = found;
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
            atomicAdd(&a.out->counted[a.pass][k], counted[k]);
        }
    }
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
        (pbwck__tested &)m = { mesh.simplices, mesh.neighbors, mesh.incident, mesh.canonical, record.at, in.count,
                             mesh.simplex_count, grid, in.dim, to == NULL };
        m.order = NULL;
        found = check_result();
        found.least = ~0ull;
        need(c, cudaMemcpyAsync(on_device.at, &found, sizeof found, cudaMemcpyHostToDevice, c.stream), "copy");
        launch(c, "check", record_kernel, over(in.count, 256), in, record.at);
    }
};

/* Tests items by the threads of a shape; list: NULL for all of them; pool: NULL without the exact stage. */
template <int DIM>
void check_items(checking &k, int pass, uint32_t count, shape threads, const uint32_t *list, pbw__digit *pool)
{
    launch(k.c, "check", check_kernel<DIM>, threads,
           check_launch{ k.m, pass, count, list, k.open.at, pool, k.on_device.at });
    k.found = read_back(k.c, k.on_device.at, PBW_STAGE_BUILD, 0.0);
}

/* Runs a pass; returns false if there is a fault, which the report then names. */
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
    if (k.found.least != ~0ull && k.report != NULL) {      /* once more, to describe it */
        const uint32_t item = (uint32_t)(k.found.least >> 32);
        need(c, cudaMemcpyAsync(k.open.at, &item, sizeof item, cudaMemcpyHostToDevice, c.stream), "copy");
        check_items<DIM>(k, pass, 1, shape{ 1, 32, 0 }, k.open.at, k.pool.at);
        const pbwck__finding &first = k.found.first;
        (void)pbwck__fault(k.report, first.fault, first.simplex, first.facet, first.point);
    }
    return k.found.least == ~0ull;
}

bool miscounts(pbw_report *report, size_t claimed, size_t counted, int fault)
{
    return claimed != counted && !pbwck__fault(report, fault, PBW_NONE, -1, PBW_NONE);
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
    if (miscounts(report, mesh.duplicate_count, (size_t)k.found.counted[check_points][2], PBWCK__FAULT_DUPLICATES)
        || miscounts(report, mesh.hidden_count, others, PBWCK__FAULT_HIDDEN)
        || !check_pass<DIM>(k, check_simplices)) {
        return false;
    }
    report->facet_count = (size_t)k.found.counted[check_simplices][0];
    report->hull_facet_count = (size_t)k.found.counted[check_simplices][1];
    return check_pass<DIM>(k, check_hull) && (others == 0 || check_pass<DIM>(k, check_hidden));
}

/* ------------------------------------------------------------------------------------------------------
   >>keep         A mesh whose points have moved, put into the order of the curve again.
   In: the last mesh of a loop, by the ids of the caller; the new coordinates and the new order of the points.  Out:
   its arrays as >>cells writes them, if it is the triangulation of the points where they are now: simplices in
   canonical form, sorted by their first three corners.
   ------------------------------------------------------------------------------------------------------ */
__global__ void compare_kernel(const uint32_t *a, const uint32_t *b, uint32_t count, uint32_t *differ)
{
    size_t i = thread_number();
    if (any(i < count && a[i] != b[i]) && (threadIdx.x & 31) == 0) {
        *differ = 1;
    }
}

/* A mesh that is put into a new order. */
struct reorder {
    const pbw_index *simplices, *neighbors;          /* in the old order */
    const uint32_t *id, *rank;                       /* of each rank; of each id */
    uint32_t count;                                  /* simplices */
    int bits;                                        /* of a rank */
};

/* The canonical form of a simplex, by ranks. */
template <int DIM> DEVICE cell<DIM> ranked(const reorder &m, uint32_t s)
{
    const cell<DIM> c = renumbered(((const cell<DIM> *)m.simplices)[s], m.rank);
    return canonical<DIM>(c.corner[0], c.corner + 1);
}

/* Makes keys to sort the simplices by: at first of 32 bits, the third corner, with the order 0, ..., count - 1; then
   of 64, the first and second corner, in the order so far. */
template <int DIM, typename KEY>
__global__ void corner_kernel(const __grid_constant__ reorder m, uint32_t *order, KEY *key)
{
    size_t i = thread_number();
    if (i < m.count) {
        const uint32_t simplex = sizeof(KEY) == 4 ? (uint32_t)i : order[i];
        const cell<DIM> c = ranked<DIM>(m, simplex);
        order[i] = simplex;
        key[i] = sizeof(KEY) == 4 ? c.corner[2] : (KEY)((uint64_t)c.corner[0] << m.bits | c.corner[1]);
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

/* Adds the last mesh of a loop to the blocks of the call, which frees them if it fails. */
void adopt_last(call &c)
{
    for (int i = 0; i < mesh_arrays; i++) {
        if (array_of(c.last->mesh, i) != NULL) {
            add_block(c, array_of(c.last->mesh, i), entries_of(c.last->mesh, i) * sizeof(pbw_index));
        }
    }
    if (c.last->id != NULL) {
        add_block(c, c.last->id, c.last->count * sizeof(uint32_t));
    }
}

/* Returns whether an earlier mesh is the triangulation of the points where they are now.  The caller knows that its
   links are sound and that its duplicates are those of the points; id: of each rank. */
template <int DIM> bool holds(call &c, const pbw_cuda_mesh &mesh, const input &in, const space &s, const uint32_t *id)
{
    checking k(c, mesh, in, s.grid, NULL);
    k.m.order = id;
    k.points = s.count;
    return check_pass<DIM>(k, check_simplices) && check_pass<DIM>(k, check_hull)
        && (mesh.hidden_count == 0 || check_pass<DIM>(k, check_hidden));
}

/* Writes the arrays of old in the order that the points have now. */
template <int DIM> void reorder_mesh(call &c, const pbw_cuda_mesh &old, const space &s, const uint32_t *id)
{
    pbw_cuda_mesh *const mesh = c.mesh;
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
    launch(c, "order", corner_kernel<DIM, uint32_t>, all, m, order.array.at, third.array.at);
    sort_pairs(c, third, order, count, { 0, bits });
    launch(c, "order", corner_kernel<DIM, uint64_t>, all, m, order.array.at, first.array.at);
    sort_pairs(c, first, order, count, { 0, 2 * bits });
    launch(c, "order", scatter_kernel, all, order.array.at, m.count, nullptr, order.spare.at);
    launch(c, "order", rewrite_kernel<DIM>, all, m, order.array.at, order.spare.at, mesh->simplices, mesh->neighbors,
           mesh->incident);
}

/* Makes the mesh from the last one; returns false if that is not the triangulation of the points. */
template <int DIM>
bool keep_mesh(call &c, const pbw_cuda_mesh &old, const input &in, const space &s, const uint32_t *id)
{
    pbw_cuda_mesh *const mesh = c.mesh;
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
        reorder_mesh<DIM>(c, old, s, id);
    }
    mesh->simplex_count = old.simplex_count;
    mesh->hidden_count = old.hidden_count;
    mesh->kept = 1;
    record_mark(c, 7);
    wait(c, PBW_STAGE_OUTPUT, 0.5);
    return true;
}

/* As keep_mesh, for a call with or without a last mesh; frees a mesh that is of no use. */
bool keep_last(call &c, const input &in, const space &s, uint32_t *id)
{
    if (c.last == NULL) {
        return false;
    }
    const pbw_cuda_mesh old = c.last->mesh;
    const bool alike = !c.rebuild && old.simplex_count > 0 && old.neighbors != NULL && old.dim == in.dim
                    && old.point_count == in.count && old.duplicate_count == c.mesh->duplicate_count;
    const bool kept = alike && (in.dim == 3 ? keep_mesh<3> : keep_mesh<2>)(c, old, in, s, id);
    if (!kept) {
        release_mesh(c, old, false);
    }
    release(c, c.last->id);
    c.last->id = id;
    c.last->count = s.count;
    return kept;
}

/* ------------------------------------------------------------------------------------------------------
   >>centres      Cells: numbers, the centres of simplices, what a simplex adds to the cells of its corners.
   In: a mesh on the device, points, a box.  Out: the sums of cells inside of the box; which cells are left.
   Holds: these rooms compute what pbw_cells.h computes, by the same expressions in the same order: the same bytes.
   So no product may be fused into a sum, which `real` prevents.

   Formulas and their derivation are in >>centres and >>totals of pbw_cells.h.
     1. A thread a simplex computes its centre, and what it adds to the cells of its corners.
     2. Pairs (vertex, 4 simplex + corner) are sorted: the simplices at each vertex, ascending.
     3. Four lanes a vertex add up x, y, z and the volume, in that order, with a sum for each chunk of 16384.
     4. Vertices with a centre outside of the box, or at the hull, are left: their cells need their stars.
   ------------------------------------------------------------------------------------------------------ */
/* A double, of which each operation is rounded. */
struct real {
    double value;
    real() = default;
    __host__ __device__ real(double from) : value(from) {}
};

#ifdef __CUDA_ARCH__
#define PBW_CUDA_REAL(symbol, rounded, plain) \
    DEVICE real operator symbol(real a, real b) { return rounded(a.value, b.value); }
#else
#define PBW_CUDA_REAL(symbol, rounded, plain) \
    __host__ __device__ inline real operator symbol(real a, real b) { return plain; }
#endif
PBW_CUDA_REAL(+, __dadd_rn, a.value + b.value)
PBW_CUDA_REAL(-, __dsub_rn, a.value - b.value)
PBW_CUDA_REAL(*, __dmul_rn, a.value * b.value)
PBW_CUDA_REAL(/, __ddiv_rn, a.value / b.value)

DEVICE real operator-(real a) { return -a.value; }
DEVICE void operator+=(real &a, real b) { a = a + b; }
DEVICE void operator-=(real &a, real b) { a = a - b; }
DEVICE bool operator<(real a, real b) { return a.value < b.value; }
DEVICE bool operator>(real a, real b) { return a.value > b.value; }
DEVICE real size_of(real a) { return fabs(a.value); }
DEVICE real root_of(real a) { return sqrt(a.value); }

DEVICE real dot(const real *a, const real *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

DEVICE void cross(const real *s, const real *t, real *x)
{
    x[0] = s[1] * t[2] - s[2] * t[1];
    x[1] = s[2] * t[0] - s[0] * t[2];
    x[2] = s[0] * t[1] - s[1] * t[0];
}

struct alignas(16) sums {                            /* of a cell: moments * 24 (2D: 6), volume * 6 (2D: 2) */
    real at[4];
};

/* The padded box of points that repeat, which has all their copies: none is missing if it holds the balls of all
   cells (>>periodic of pbw_cells.h). */
struct padded_box {
    unsigned axes;                                   /* along which they repeat */
    double size[3], margin[3], heaviest, slack;      /* heaviest: weight; slack: for rounding */
    uint32_t *good;                                  /* to be cleared if it does not hold a ball */
    unsigned char *is_cut;                           /* per point: did walls cut its cell?  NULL: there are none */
};

/* A diagram in a box, or in the whole space: then nothing is bounded, and low and high are infinite.  So they are
   along axes that repeat, where a cell is in a box around its site: from and to are relative to that. */
struct diagram {
    const uint32_t *simplices, *neighbors, *incident;
    const double *points, *weights;                  /* weights: NULL = none */
    uint32_t simplex_count, start, count;            /* cells: of the points from start to count - 1 */
    bool bounded;
    double low[3], high[3], slack[3], extent[3];     /* slack: for the rounding of the box */
    double from[3], to[3];
    padded_box padded;
    double *volumes, *centroids;
};

const unsigned good_centre = 1, inside_box = 2;

DEVICE bool has_cell(const diagram &d, size_t v)
{
    return v >= d.start && v < d.count;
}

/* Whether a + x is certainly in the box. */
template <int DIM> DEVICE bool is_inside(const diagram &d, const double *a, const real *x)
{
    real radius = 0.0;
    bool inside = true;
    for (int k = 0; k < DIM; k++) {
        radius += size_of(x[k]);
    }
    for (int k = 0; k < DIM; k++) {                  /* if in doubt, cut */
        const real at = real(a[k]) + x[k], slack = real(1e-12) * radius + d.slack[k];
        inside = inside && at - d.low[k] > slack && real(d.high[k]) - at > slack;
    }
    return inside;
}

/* A corner of the box from v. */
template <int DIM> DEVICE real box_corner(const diagram &d, uint32_t v, int k, bool high)
{
    const bool repeats = (d.padded.axes >> k & 1) != 0;
    return real(high ? d.to[k] : d.from[k]) - (repeats ? 0.0 : d.points[(size_t)v * DIM + (size_t)k]);
}

/* Clears *p.good if the padded box does not hold the ball around x.  square: of its radius. */
template <int DIM> DEVICE void hold_ball(const padded_box &p, const real *x, real square)
{
    const double radius = sqrt(square > 0.0 ? square.value : 0.0) * (1 + 1e-9) + p.slack;
    for (int k = 0; k < DIM; k++) {
        if ((p.axes >> k & 1) != 0
            && !(x[k].value - radius > -p.margin[k] && x[k].value + radius < p.size[k] + p.margin[k])) {
            *p.good = 0;
        }
    }
}

/* The ball at a corner of the cell of v, which the walls have cut; x: from v. */
template <int DIM> DEVICE void hold_corner(const diagram &d, uint32_t v, const real *x)
{
    real at[DIM], square = d.weights != NULL ? real(d.padded.heaviest) - d.weights[v] : real(0.0);
    for (int k = 0; k < DIM; k++) {
        square += x[k] * x[k];
        at[k] = x[k] + d.points[(size_t)v * DIM + (size_t)k];
    }
    hold_ball<DIM>(d.padded, at, square);
}

/* The centre of a simplex by pairs of doubles; returns whether it is good. */
template <int DIM> DEVICE_CALL bool exact_centre(const diagram &d, const uint32_t *corner, real *centre)
{
    const double *at[4];
    double weight[4], x[3];
    for (int i = 0; i <= DIM; i++) {
        at[i] = d.points + (size_t)corner[i] * DIM;
        weight[i] = d.weights != NULL ? d.weights[corner[i]] : 0.0;
    }
    const bool is_good = pbw_centre(DIM, at, d.weights != NULL ? weight : NULL, x) != 0;
    for (int k = 0; k < DIM; k++) {
        centre[k] = x[k];
    }
    return is_good;
}

DEVICE bool is_thick(real det, real largest)
{
    return det > 0.0 && det * det > real(1e-12) * largest * largest * largest;
}

/* The centre relative to the first corner; returns its flags. */
template <int DIM> DEVICE unsigned centre_of(const diagram &d, uint32_t simplex, real *centre)
{
    const uint32_t *corner = d.simplices + (size_t)simplex * (DIM + 1);
    const double *a = d.points + (size_t)corner[0] * DIM;
    real r[DIM][DIM], height[DIM], largest = 0.0;
    bool is_good;
    for (int i = 0; i < DIM; i++) {
        const double *b = d.points + (size_t)corner[i + 1] * DIM;
        height[i] = 0.0;
        for (int k = 0; k < DIM; k++) {
            r[i][k] = real(b[k]) - a[k];
            height[i] += r[i][k] * r[i][k];
        }
        largest = height[i] > largest ? height[i] : largest;
        if (d.weights != NULL) {
            height[i] -= real(d.weights[corner[i + 1]]) - d.weights[corner[0]];
        }
    }
    if (DIM == 2) {
        const real det = r[0][0] * r[1][1] - r[0][1] * r[1][0];
        is_good = det > real(1e-6) * largest;
        centre[0] = (height[0] * r[1][1] - height[1] * r[0][1]) / (real(2.0) * det);
        centre[1] = (height[1] * r[0][0] - height[0] * r[1][0]) / (real(2.0) * det);
    } else {
        real m[3][3];
        for (int i = 0; i < 3; i++) {
            cross(r[(i + 1) % 3], r[(i + 2) % 3], m[i]);
        }
        const real det = dot(r[0], m[0]);
        is_good = is_thick(det, largest);
        for (int k = 0; k < 3; k++) {
            centre[k] = (height[0] * m[0][k] + height[1] * m[1][k] + height[2] * m[2][k]) * (real(0.5) / det);
        }
    }
    is_good = is_good || exact_centre<DIM>(d, corner, centre);
    return (is_good ? good_centre : 0) | (is_good && is_inside<DIM>(d, a, centre) ? inside_box : 0);
}

/* A simplex: edges 01 02 03 12 13 23, facets across from the corners. */
struct simplex_geometry {
    real edge[6][3], square[6], weight[4];
    real foot[6];                                    /* of the plane between the cells, along the edge */
    real normal[4][3], drop[4];
    real to[4][3];                                   /* from the corners to the centre */
    real sum[4][4];                                  /* for the corners */
    real given[6];
};

/* {0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3} */
DEVICE int edge_end(int edge, int end)
{
    return end == 0 ? (edge > 2) + (edge > 4) : edge < 3 ? edge + 1 : edge == 3 ? 2 : 3;
}

template <bool WEIGHTED> DEVICE void load_simplex(const diagram &d, const uint32_t *corner, simplex_geometry &g)
{
    real x[4][3];
#pragma unroll
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) {
            x[i][k] = d.points[(size_t)corner[i] * 3 + (size_t)k];
        }
        g.weight[i] = WEIGHTED ? d.weights[corner[i]] : 0.0;
    }
#pragma unroll
    for (int e = 0; e < 6; e++) {
        const int i = edge_end(e, 0), j = edge_end(e, 1);
        for (int k = 0; k < 3; k++) {
            g.edge[e][k] = x[j][k] - x[i][k];
        }
        g.square[e] = dot(g.edge[e], g.edge[e]);
        g.given[e] = g.square[e] - g.square[e];
        g.foot[e] = 0.5;
        if (WEIGHTED) {
            g.foot[e] = real(0.5) + (g.weight[i] - g.weight[j]) / (real(2.0) * g.square[e]);
        }
    }
}

/* The normals and the centre; returns its flags. */
template <bool WEIGHTED>
DEVICE unsigned find_centre(const diagram &d, const uint32_t *corner, simplex_geometry &g)
{
    real height[3];
#pragma unroll
    for (int i = 0; i < 3; i++) {
        cross(g.edge[(i + 1) % 3], g.edge[(i + 2) % 3], g.normal[i + 1]);
        height[i] = g.square[i];
        if (WEIGHTED) {
            height[i] -= g.weight[i + 1] - g.weight[0];
        }
    }
    const real det = dot(g.edge[0], g.normal[1]), most = g.square[0] > g.square[1] ? g.square[0] : g.square[1];
    const real largest = most > g.square[2] ? most : g.square[2];
#pragma unroll
    for (int k = 0; k < 3; k++) {
        g.normal[0][k] = -(g.normal[1][k] + g.normal[2][k] + g.normal[3][k]);
        g.to[0][k] = (height[0] * g.normal[1][k] + height[1] * g.normal[2][k] + height[2] * g.normal[3][k])
                     * (real(0.5) / det);
    }
    bool is_good = is_thick(det, largest);
    if (!is_good) {
        real centre[3];                              /* by its address: the rest stays in registers */
        is_good = exact_centre<3>(d, corner, centre);
        for (int k = 0; k < 3; k++) {
            g.to[0][k] = centre[k];
        }
    }
    is_good = is_good && largest > 1e-60 && largest < 1e60;          /* else products may be out of range */
    return (is_good ? good_centre : 0)
         | (is_good && is_inside<3>(d, d.points + (size_t)corner[0] * 3, g.to[0]) ? inside_box : 0);
}

/* Adds what facet f with corners i < j < k contributes; edges: ij, ik, jk. */
template <bool WEIGHTED> DEVICE void add_facet(simplex_geometry &g, int f)
{
    const int corner[3] = { f == 0, 1 + (f < 2), 2 + (f < 3) };
    const int edge[3] = { f == 0 ? 3 : f == 1 ? 1 : 0, f == 0 ? 4 : f == 3 ? 1 : 2, f < 2 ? 5 : f == 2 ? 4 : 3 };
    const real *ij = g.edge[edge[0]], *ik = g.edge[edge[1]], *jk = g.edge[edge[2]], *square = g.square;
    const real half = real(0.5) * g.drop[f];
    const real at[3] = { dot(ij, ik), -dot(ij, jk), dot(ik, jk) };
    real part[3], h[3] = { square[edge[0]] * at[2], square[edge[1]] * at[1], square[edge[2]] * at[0] };
    if (WEIGHTED) {
        const real wj = g.weight[corner[1]] - g.weight[corner[0]], wk = g.weight[corner[2]] - g.weight[corner[0]];
        h[0] -= square[edge[0]] * wk - at[0] * wj;
        h[1] -= square[edge[1]] * wj - at[0] * wk;
        h[2] += square[edge[2]] * wj + at[1] * (wk - wj);
    }
    for (int i = 0; i < 3; i++) {
        h[i] = h[i] * half;
        g.given[edge[i]] += h[i];
    }
    if (WEIGHTED) {
        const real one = 1.0, a = g.foot[edge[0]], b = g.foot[edge[1]], c = g.foot[edge[2]];
        part[0] = a * h[0] + b * h[1];
        part[1] = (one - a) * h[0] + c * h[2];
        part[2] = (one - b) * h[1] + (one - c) * h[2];
    } else {
        part[0] = real(0.5) * (h[0] + h[1]);
        part[1] = real(0.5) * (h[0] + h[2]);
        part[2] = real(0.5) * (h[1] + h[2]);
    }
    for (int i = 0; i < 3; i++) {
        const real drop = part[i] * g.drop[f];
        for (int k = 0; k < 3; k++) {
            g.sum[corner[i]][k] -= drop * g.normal[f][k];
        }
        g.sum[corner[i]][3] += part[i];
    }
}

template <bool WEIGHTED> DEVICE void sum_corners(simplex_geometry &g)
{
#pragma unroll
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 4; k++) {
            g.sum[i][k] = 0.0;
            if (i > 0 && k < 3) {
                g.to[i][k] = g.to[0][k] - g.edge[i - 1][k];
            }
        }
    }
#pragma unroll
    for (int i = 0; i < 4; i++) {
        g.drop[i] = dot(g.to[i == 0], g.normal[i]) / dot(g.normal[i], g.normal[i]);
        add_facet<WEIGHTED>(g, i);
    }
#pragma unroll
    for (int e = 0; e < 6; e++) {
        const real one = 1.0, foot = g.foot[e];
        const real first = WEIGHTED ? g.given[e] * foot * foot : real(0.25) * g.given[e];
        const real second = WEIGHTED ? g.given[e] * (one - foot) * (one - foot) : first;
        for (int k = 0; k < 3; k++) {
            g.sum[edge_end(e, 0)][k] += first * g.edge[e][k];
            g.sum[edge_end(e, 1)][k] -= second * g.edge[e][k];
        }
    }
#pragma unroll
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) {
            g.sum[i][k] += real(2.0) * g.sum[i][3] * g.to[i][k];
        }
    }
}

struct alignas(16) edge_parts {                      /* of a simplex: its parts of the areas of six facets */
    real at[6];
};

/* What simplices add to the cells of their corners, and to facets. */
struct contributions {
    sums *sum[4];                                    /* per corner, of each simplex */
    edge_parts *part;                                /* NULL: no facets are wanted */
    unsigned char *left;                             /* per vertex: is its cell left? */
};

template <bool WEIGHTED, bool FACETS>
DEVICE void contribute(const diagram &d, const contributions &out, uint32_t simplex)
{
    simplex_geometry g;
    uint32_t corner[4], next[4];
    for (int i = 0; i < 4; i++) {
        corner[i] = d.simplices[4 * (size_t)simplex + (size_t)i];
        next[i] = d.neighbors[4 * (size_t)simplex + (size_t)i];
    }
    load_simplex<WEIGHTED>(d, corner, g);
    const unsigned flags = find_centre<WEIGHTED>(d, corner, g);
    const bool all = (flags & (d.bounded ? inside_box : good_centre)) == 0;
    sum_corners<WEIGHTED>(g);
#pragma unroll
    for (int i = 0; i < 4; i++) {
        const bool at_hull = next[(i + 1) & 3] == none || next[(i + 2) & 3] == none || next[(i + 3) & 3] == none;
        sums sum;
        for (int k = 0; k < 4; k++) {
            sum.at[k] = g.sum[i][k];
        }
        out.sum[i][simplex] = sum;
        if (all || at_hull) {
            out.left[corner[i]] = 1;
        }
    }
    if (FACETS) {
        edge_parts part;
#pragma unroll
        for (int e = 0; e < 6; e++) {
            part.at[e] = g.given[e] / (real(2.0) * root_of(g.square[e]));
        }
        out.part[simplex] = part;
    }
}

/* A coordinate, not -0, as in meshes of the host. */
DEVICE real coordinate(const diagram &d, size_t i)
{
    return real(d.points[i]) + 0.0;
}

/* Sets the volume and the centroid of v by its sums. */
template <int DIM> DEVICE void set_cell(const diagram &d, uint32_t v, const real *sum)
{
    const bool some = sum[3] > 0.0;
    d.volumes[v] = some ? (sum[3] / (DIM == 3 ? 6.0 : 2.0)).value : 0.0;
    for (int k = 0; k < DIM; k++) {
        const size_t at = (size_t)v * DIM + (size_t)k;
        const real site = coordinate(d, at);
        d.centroids[at] = (some ? site + sum[k] / (sum[3] * (DIM == 3 ? 4.0 : 3.0)) : site).value;
    }
}

/* The cell of a vertex without an end: its volume is infinite. */
template <int DIM> DEVICE void set_unbounded(const diagram &d, uint32_t v)
{
    const real nothing[4] = { 0.0, 0.0, 0.0, 0.0 };
    set_cell<DIM>(d, v, nothing);
    d.volumes[v] = HUGE_VAL;
}

const int contribute_block = 128;

template <bool WEIGHTED, bool FACETS>
__global__ void __launch_bounds__(contribute_block) contribute_kernel(const diagram d, const contributions out)
{
    const size_t simplex = thread_number();
    bool is_read = false;
    for (size_t i = 0; i < 4 && simplex < d.simplex_count; i++) {
        is_read = is_read || has_cell(d, d.simplices[4 * simplex + i]);
    }
    if (is_read) {
        contribute<WEIGHTED, FACETS>(d, out, (uint32_t)simplex);
    }
}

/* first[v], ..., first[v + 1] - 1: the entries of v in the sorted pairs. */
__global__ void find_first_kernel(const uint32_t *vertex, size_t entries, uint32_t *first, uint32_t count)
{
    const size_t i = thread_number();
    if (i <= entries) {
        const uint32_t before = i > 0 ? vertex[i - 1] + 1 : 0, here = i < entries ? vertex[i] : count;
        for (uint32_t v = before; v <= here && v <= count; v++) {
            first[v] = (uint32_t)i;
        }
    }
}

/* The simplices at each vertex. */
struct stars {
    const uint32_t *first, *entry;
};

const uint32_t chunk_bits = 14;                      /* simplices of a chunk of pbw_cells.h: 2^14 */

__global__ void sum_kernel(const diagram d, const contributions in, const stars s, const queue left)
{
    const size_t v = d.start + thread_number() / 4;
    const int k = (int)(threadIdx.x & 3);
    const bool go = v < d.count;
    const uint32_t end = go ? s.first[v + 1] : 0, begin = go ? s.first[v] : 0;
    uint32_t chunk = begin < end ? s.entry[begin] >> (chunk_bits + 2) : 0;
    real part = 0.0, sum[4], all = 0.0;
    for (uint32_t i = begin; i < end; i++) {
        const uint32_t entry = s.entry[i];
        if (entry >> (chunk_bits + 2) != chunk) {
            chunk = entry >> (chunk_bits + 2);
            all = part + all;
            part = 0.0;
        }
        part += in.sum[entry & 3][entry >> 2].at[k];
    }
    all = part + all;
    for (int i = 0; i < 4; i++) {
        sum[i] = __shfl_sync(all_lanes, all.value, i, 4);
    }
    const bool is_left = go && begin < end && in.left[v] != 0;
    if (go && !is_left && k == 0) {
        set_cell<3>(d, (uint32_t)v, sum);
    }
    int length = 0;
    const int at = append<32>(is_left && k == 0, length);
    uint32_t base = 0;
    if (length > 0 && (threadIdx.x & 31) == 0) {
        base = atomicAdd(left.count, (uint32_t)length);
    }
    base = __shfl_sync(all_lanes, base, 0);
    if (is_left && k == 0) {
        left.vertex[base + (uint32_t)at] = (uint32_t)v;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>polytopes    Cells: a polytope cut by planes, by a warp.
   In: corners and facets of a convex polytope, a plane.  Out: the part on one side of it; the sums of the cell.
   Holds: corners, facets and the entries of their loops have the numbers that >>polytopes of pbw_cells.h gives them.

   A facet is a loop of corners, counter-clockwise from outside.  Corners are never moved; those cut off stay, in no
   loop.  The lanes share the entries of all loops.  A cut:
     1. The distance of each corner from the plane.
     2. The loops without the corners beyond.  Where an edge crosses the plane, an entry stays open.
     3. The crossings in order: the first one of an edge makes a corner, and fills the open entries of the edge.
     4. Neighbours on the plane are an edge of the cap, which has it the other way round.
   ------------------------------------------------------------------------------------------------------ */
/* Calls f(i) for all i below count, one a lane. */
template <typename F> DEVICE void warp_each(uint32_t count, F f)
{
    for (uint32_t i = threadIdx.x & 31; i < count; i += 32) {
        f(i);
    }
    __syncwarp();
}

/* Calls f by one lane. */
template <typename F> DEVICE void warp_once(F f)
{
    if ((threadIdx.x & 31) == 0) {
        f();
    }
    __syncwarp();
}

/* Calls put(i, flags(i), how many before i have bit 0, how many have bit 1); returns those of all. */
template <typename F, typename P> DEVICE uint2 warp_number(uint32_t count, F flags, P put)
{
    const uint32_t lane = threadIdx.x & 31;
    uint2 sum = { 0, 0 };
    for (uint32_t from = 0; from < count; from += 32) {
        const uint32_t i = from + lane;
        const unsigned mine = i < count ? flags(i) : 0;
        const unsigned one = __ballot_sync(all_lanes, mine & 1), two = __ballot_sync(all_lanes, mine & 2);
        if (i < count) {
            put(i, mine, sum.x + __popc(one & lanes_below<32>()), sum.y + __popc(two & lanes_below<32>()));
        }
        sum.x += __popc(one);
        sum.y += __popc(two);
    }
    __syncwarp();
    return sum;
}

/* Calls put(i, the sum of get(0), ..., get(i - 1)); returns that of all. */
template <typename F, typename P> DEVICE uint32_t warp_sum_before(uint32_t count, F get, P put)
{
    const uint32_t lane = threadIdx.x & 31;
    uint32_t sum = 0;
    for (uint32_t from = 0; from < count; from += 32) {
        const uint32_t mine = from + lane < count ? get(from + lane) : 0;
        uint32_t upto = mine;
        for (int step = 1; step < 32; step *= 2) {
            const uint32_t other = __shfl_up_sync(all_lanes, upto, step);
            upto += lane >= step ? other : 0;
        }
        if (from + lane < count) {
            put(from + lane, sum + upto - mine);
        }
        sum += __shfl_sync(all_lanes, upto, 31);
    }
    __syncwarp();
    return sum;
}

/* Adds the terms get(i, term) to four sums, in the order of i.  room: for 128 numbers. */
template <typename F> DEVICE void warp_add_in_order(uint32_t count, real *room, F get, real *sum)
{
    const uint32_t lane = threadIdx.x & 31;
    real mine = sum[lane & 3];
    for (uint32_t from = 0; from < count; from += 32) {
        real term[4] = { 0.0, 0.0, 0.0, 0.0 };       /* added, it changes nothing: no sum is -0 */
        if (from + lane < count) {
            get(from + lane, term);
        }
        for (int k = 0; k < 4; k++) {
            room[4 * lane + k] = term[k];
        }
        __syncwarp();
        for (uint32_t i = 0; i < 32 && from + i < count; i++) {
            mine += room[4 * i + (lane & 3)];
        }
        __syncwarp();
    }
    for (int k = 0; k < 4; k++) {
        sum[k] = __shfl_sync(all_lanes, mine.value, k);
    }
}

DEVICE void max_at(uint32_t *at, uint32_t value) { atomicMax(at, value); }
DEVICE void min_at(uint32_t *at, uint32_t value) { atomicMin(at, value); }
DEVICE void add_at(uint32_t *at, uint32_t value) { atomicAdd(at, value); }

/* Writes a value if the word is as expected; returns what it was. */
DEVICE uint32_t claim(uint32_t *at, uint32_t expected, uint32_t value) { return atomicCAS(at, expected, value); }

struct room_sizes {
    uint32_t simplices, links, slots, corners, entries, facets, crossings;   /* slots: a power of two */
};

template <typename INDEX> struct loops_of {
    INDEX *corner, *facet;                           /* per entry */
    INDEX *start, *name;                             /* per facet, start: one more; a name: a link, or ~wall */
};

enum { links_found, facets_made, entries_made, room_totals };

/* A star and its polytope in the memory of a warp. */
template <typename INDEX> struct cell_room {
    room_sizes size;
    real *x, *side;                                  /* per corner; side: beyond the plane; then terms of sums */
    uint32_t *simplex, *first_use;                   /* per simplex of the star: its number, ascending; its entry */
    uint32_t *key, *size_of_ring;                    /* per slot: the vertex of a link; the simplices at it */
    uint32_t *after;                                 /* per new corner: 1 + the entry of the next one in a cap */
    uint32_t *total;                                 /* what one lane tells all */
    INDEX *corner, *across, *corner_of;              /* per simplex: three slots; its neighbours there; its centre */
    INDEX *link_of;                                  /* per slot */
    INDEX *slot_of, *begin, *p, *q;                  /* per link: its slot, where its ring starts */
    INDEX *began;                                    /* per facet: where what the cut left of it starts */
    INDEX *low, *high, *place, *maker, *made;        /* per crossing: edge, entry; which one makes what corner */
    loops_of<INDEX> now, next;
};

/* Lays a room out in memory; with NULL only counts its bytes. */
template <typename INDEX>
HOST_DEVICE size_t lay_out(const room_sizes &size, char *memory, cell_room<INDEX> &room)
{
    size_t used = 0;
    auto take = [&](auto *&array, size_t count) {
        typedef typename std::remove_reference<decltype(*array)>::type item;
        used = (used + sizeof(item) - 1) / sizeof(item) * sizeof(item);
        array = memory != NULL ? (item *)(memory + used) : NULL;
        used += count * sizeof(item);
    };
    room.size = size;
    take(room.x, 3 * (size_t)size.corners);
    take(room.side, size.corners > 128 ? size.corners : 128);
    take(room.simplex, size.simplices);
    take(room.first_use, size.simplices);
    take(room.key, size.slots);
    take(room.size_of_ring, size.slots);
    take(room.after, size.crossings);
    take(room.total, room_totals);
    take(room.corner, 3 * (size_t)size.simplices);
    take(room.across, 3 * (size_t)size.simplices);
    take(room.corner_of, size.simplices);
    take(room.link_of, size.slots);
    take(room.slot_of, size.links);
    take(room.begin, size.links);
    take(room.p, size.links);
    take(room.q, size.links);
    take(room.began, size.facets + 1);
    take(room.low, size.crossings);
    take(room.high, size.crossings);
    take(room.place, size.crossings);
    take(room.maker, size.crossings);
    take(room.made, size.crossings);
    for (int i = 0; i < 2; i++) {
        loops_of<INDEX> &loops = i == 0 ? room.now : room.next;
        take(loops.corner, size.entries);
        take(loops.facet, size.entries);
        take(loops.start, size.facets + 1);
        take(loops.name, size.facets);
    }
    return (used + 15) / 16 * 16;
}

/* The counts of a polytope. */
struct counts {
    uint32_t corners, facets, entries;
};

template <typename INDEX> DEVICE bool crosses(const cell_room<INDEX> &r, uint32_t a, uint32_t b)
{
    return (r.side[a] > 0.0 && r.side[b] < 0.0) || (r.side[a] < 0.0 && r.side[b] > 0.0);
}

/* The corner after that of an entry. */
template <typename INDEX> DEVICE uint32_t follower(const loops_of<INDEX> &loops, uint32_t entry)
{
    const uint32_t facet = loops.facet[entry];
    return loops.corner[entry + 1 < loops.start[facet + 1] ? entry + 1 : loops.start[facet]];
}

/* Step 2.  Returns the crossings, and the counts of what is kept. */
template <typename INDEX> DEVICE uint32_t cut_loops(cell_room<INDEX> &r, counts &n)
{
    const loops_of<INDEX> &from = r.now, &to = r.next;
    const uint2 found = warp_number(n.entries, [&](uint32_t e) {
        const uint32_t a = from.corner[e];
        return (r.side[a] > 0.0 ? 0u : 1u) | (crosses(r, a, follower(from, e)) ? 2u : 0u);
    }, [&](uint32_t e, unsigned flags, uint32_t kept, uint32_t crossing) {
        const uint32_t a = from.corner[e], at = kept + crossing;
        if (e == from.start[from.facet[e]]) {
            r.began[from.facet[e]] = (INDEX)at;
        }
        if ((flags & 1) != 0 && at < r.size.entries) {
            to.corner[at] = (INDEX)a;
        }
        if ((flags & 2) != 0 && crossing < r.size.crossings) {
            const uint32_t b = follower(from, e);
            r.low[crossing] = (INDEX)(a < b ? a : b);
            r.high[crossing] = (INDEX)(a < b ? b : a);
            r.place[crossing] = (INDEX)(at + (flags & 1));
        }
    });
    n.entries = found.x + found.y;
    if (n.entries + found.y > r.size.entries || found.y > r.size.crossings) {
        return found.y;
    }
    warp_once([&]() { r.began[n.facets] = (INDEX)n.entries; });
    n.facets = warp_number(n.facets, [&](uint32_t f) { return r.began[f] < r.began[f + 1] ? 1u : 0u; },
                           [&](uint32_t f, unsigned flags, uint32_t before, uint32_t) {
        if (flags != 0) {
            to.start[before] = r.began[f];
            to.name[before] = from.name[f];
        }
        for (uint32_t e = r.began[f]; e < r.began[f + 1]; e++) {
            to.facet[e] = (INDEX)before;
        }
    }).x;
    warp_once([&]() { to.start[n.facets] = (INDEX)n.entries; });
    return found.y;
}

/* Step 3.  Returns the number of new corners, in next. */
template <typename INDEX> DEVICE uint32_t fill_crossings(cell_room<INDEX> &r, uint32_t crossings, uint32_t corners)
{
    warp_each(crossings, [&](uint32_t i) {
        uint32_t first = 0;
        while (r.low[first] != r.low[i] || r.high[first] != r.high[i]) {
            first++;
        }
        r.maker[i] = (INDEX)first;
    });
    const uint32_t made = warp_number(crossings, [&](uint32_t i) { return r.maker[i] == i ? 1u : 0u; },
                                      [&](uint32_t i, unsigned flags, uint32_t before, uint32_t) {
        const uint32_t low = r.low[i], high = r.high[i], corner = corners + before;
        r.made[i] = (INDEX)corner;
        if (flags != 0 && corner < r.size.corners) {
            const real t = r.side[low] / (r.side[low] - r.side[high]);
            for (int k = 0; k < 3; k++) {
                const real a = r.x[3 * low + k], b = r.x[3 * high + k];
                r.x[3 * corner + k] = a + t * (b - a);
            }
            r.after[before] = 0;
        }
    }).x;
    warp_each(crossings, [&](uint32_t i) { r.next.corner[r.place[i]] = r.made[r.maker[i]]; });
    return made;
}

/* Step 4. */
template <typename INDEX> DEVICE void add_caps(cell_room<INDEX> &r, counts &n, uint32_t made, uint32_t name)
{
    const loops_of<INDEX> &to = r.next;
    warp_each(n.entries, [&](uint32_t e) {
        const uint32_t a = to.corner[e], b = follower(to, e);
        if (a >= n.corners && b >= n.corners) {
            max_at(r.after + (b - n.corners), e + 1);
        }
    });
    warp_once([&]() {
        uint32_t facets = n.facets, entries = n.entries;
        for (uint32_t i = 0; i < made; i++) {
            const uint32_t from = entries;
            for (uint32_t at = i, then; r.after[at] != 0; at = then) {
                to.corner[entries] = (INDEX)(n.corners + at);
                to.facet[entries++] = (INDEX)facets;
                then = to.corner[r.after[at] - 1] - n.corners;
                r.after[at] = 0;
            }
            if (entries - from < 3) {
                entries = from;
            } else {
                to.name[facets] = (INDEX)name;
                to.start[++facets] = (INDEX)entries;
            }
        }
        r.total[facets_made] = facets;
        r.total[entries_made] = entries;
    });
    n.facets = r.total[facets_made];
    n.entries = r.total[entries_made];
    n.corners += made;
}

/* Keeps the part with plane.x <= c.  Returns false if the room is too small. */
template <typename INDEX>
DEVICE bool cut_polytope(cell_room<INDEX> &r, counts &n, const real *plane, real c, uint32_t name)
{
    const real tiny = 2.3e-308;
    bool outside = false;
    warp_each(n.corners, [&](uint32_t i) {
        const real s = plane[0] * r.x[3 * i] + plane[1] * r.x[3 * i + 1] + plane[2] * r.x[3 * i + 2] - c;
        r.side[i] = s < 0.0 || s > 0.0 ? s : -tiny;
        outside = outside || s > 0.0;
    });
    if (!any(outside)) {
        return true;
    }
    const uint32_t crossings = cut_loops(r, n);
    if (n.entries + crossings > r.size.entries || crossings > r.size.crossings
        || n.facets + crossings / 3 + 1 > r.size.facets) {
        return false;
    }
    const uint32_t made = fill_crossings(r, crossings, n.corners);
    if (n.corners + made > r.size.corners) {
        return false;
    }
    add_caps(r, n, made, name);
    exchange(r.now, r.next);
    return true;
}

/* Adds the cones of all facets over the site. */
template <typename INDEX> DEVICE void sum_polytope(const cell_room<INDEX> &r, const counts &n, real *sum)
{
    warp_add_in_order(n.entries, r.side, [&](uint32_t e, real *term) {
        const uint32_t facet = r.now.facet[e], start = r.now.start[facet], end = r.now.start[facet + 1];
        if (e > start && e + 1 < end) {
            const real *a = r.x + 3 * (size_t)r.now.corner[start];
            const real *b = r.x + 3 * (size_t)r.now.corner[e], *c = r.x + 3 * (size_t)r.now.corner[e + 1];
            real across[3];
            cross(b, c, across);
            term[3] = dot(a, across);
            for (int k = 0; k < 3; k++) {
                term[k] = term[3] * (a[k] + b[k] + c[k]);
            }
        }
    }, sum);
}

/* ------------------------------------------------------------------------------------------------------
   >>diagram      Cells: the star of a vertex by a warp, and its cell.
   In: the sorted simplices at each vertex.  Out: the cells that are left.
   Holds: links are in the order, and rings start, where the walks of >>stars of pbw_cells.h find them.  Facets of
   cells that the box does not cut are in the order of >>facets there.

   The star is brought into the room with small numbers: simplices by their place, links by the slot of a hash table.
   One lane walks until all links are known.  Then a lane a link walks its ring, which is a facet of the polytope.
   ------------------------------------------------------------------------------------------------------ */
/* Facets: the counts of all cells in first, or, with neighbours, where those of each cell begin.  In space cells that
   are left have theirs in lists of their own at begin, with counts. */
struct facet_lists {
    size_t *first;                                   /* NULL: no facets are wanted */
    uint32_t *neighbor;
    double *area;
    size_t all;
    size_t *begin;
    const edge_parts *part;                          /* per simplex */
    const unsigned char *is_left;                    /* per vertex: is its volume not known? */
};

/* Takes the facets of a cell one by one; of a cell that proves to be left, no more than have a place in the lists. */
struct facet_writer {
    const facet_lists *lists;
    size_t at, end, count;
    DEVICE facet_writer(const facet_lists &to, uint32_t v) : lists(&to), at(0), end(0), count(0)
    {
        if (to.neighbor != NULL) {
            at = to.first[v];
            end = to.first[v + 1];
        }
    }
    DEVICE void take(uint32_t neighbor, real area)
    {
        if (at + count < end) {
            lists->neighbor[at + count] = neighbor;
            lists->area[at + count] = area.value;
        }
        count++;
    }
    DEVICE void set_count(uint32_t v)
    {
        if (lists->first != NULL && lists->neighbor == NULL) {
            lists->first[v] = count;
        }
    }
};

/* {1,2,3}, {0,3,2}, {3,0,1}, {2,1,0}: with corner i before them they are positively oriented. */
DEVICE uint32_t other_corner(uint32_t i, uint32_t k)
{
    return 0x06132c39u >> (8 * i + 2 * k) & 3;
}

template <typename INDEX> DEVICE bool is_known(const cell_room<INDEX> &r, uint32_t slot)
{
    return r.link_of[slot] != (INDEX)~0u;
}

/* The place of a simplex among those of a star. */
DEVICE uint32_t place_of(const uint32_t *star, uint32_t count, uint32_t simplex)
{
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        const uint32_t middle = (low + high) / 2;
        if (star[middle] < simplex) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/* The slot of a vertex, new at its first use. */
DEVICE uint32_t slot_of(uint32_t *key, uint32_t slots, uint32_t vertex)
{
    uint32_t slot = vertex * 2654435761u >> 7 & (slots - 1);
    while (true) {
        const uint32_t before = claim(key + slot, none, vertex);
        if (before == none || before == vertex) {
            return slot;
        }
        slot = (slot + 1) & (slots - 1);
    }
}

/* Brings the star of v into the room.  Returns whether it is at the hull. */
template <typename INDEX>
DEVICE bool fetch_star(const diagram &d, const cell_room<INDEX> &r, const uint32_t *entry, uint32_t count)
{
    bool open = false;
    warp_each(r.size.slots, [&](uint32_t i) {
        r.key[i] = none;
        r.size_of_ring[i] = 0;
        r.link_of[i] = (INDEX)~0u;
    });
    warp_each(count, [&](uint32_t i) {
        r.simplex[i] = entry[i] >> 2;
        r.first_use[i] = none;
    });
    warp_each(3 * count, [&](uint32_t i) {
        const size_t at = 4 * (size_t)(entry[i / 3] >> 2) + other_corner(entry[i / 3] & 3, i % 3);
        const uint32_t slot = slot_of(r.key, r.size.slots, d.simplices[at]), next = d.neighbors[at];
        add_at(r.size_of_ring + slot, 1);
        r.corner[i] = (INDEX)slot;
        r.across[i] = (INDEX)(next == none ? ~0u : place_of(r.simplex, count, next));
        open = open || next == none;
    });
    return any(open);
}

/* Where a walk around the edge from the site to a link is: a simplex of the star, and its two other corners. */
struct walk_place {
    uint32_t simplex, p, q;
};

template <typename INDEX> DEVICE uint32_t across(const cell_room<INDEX> &r, uint32_t simplex, uint32_t slot)
{
    const INDEX *corner = r.corner + 3 * simplex;
    return r.across[3 * simplex + (corner[1] == slot) + 2 * (corner[2] == slot)];
}

/* The corner of a simplex besides two. */
template <typename INDEX> DEVICE uint32_t third(const cell_room<INDEX> &r, uint32_t simplex, uint32_t a, uint32_t b)
{
    const INDEX *corner = r.corner + 3 * simplex;
    return (uint32_t)(corner[0] ^ corner[1] ^ corner[2]) ^ a ^ b;
}

template <typename INDEX>
DEVICE void add_link(const cell_room<INDEX> &r, uint32_t &links, uint32_t slot, const walk_place &from)
{
    if (!is_known(r, slot)) {
        r.link_of[slot] = (INDEX)links;
        r.slot_of[links] = (INDEX)slot;
        r.begin[links] = (INDEX)from.simplex;
        r.p[links] = (INDEX)from.p;
        r.q[links++] = (INDEX)from.q;
    }
}

/* Walks around the link at slot u, back to the start or to the hull, and adds new links.  Returns whether it is
   back. */
template <typename INDEX>
DEVICE bool walk_around(const cell_room<INDEX> &r, uint32_t &links, uint32_t u, walk_place &at)
{
    const uint32_t first = at.simplex, outside = (INDEX)~0u;
    while (true) {
        const uint32_t next = across(r, at.simplex, at.p);
        add_link(r, links, at.q, { at.simplex, u, at.p });
        if (next == outside || next == first) {
            return next == first;
        }
        at = { next, at.q, third(r, next, u, at.q) };
    }
}

/* Numbers the links, by one lane; start: the simplex from which the walks start. */
template <typename INDEX> DEVICE void find_links(const cell_room<INDEX> &r, uint32_t start, uint32_t all)
{
    uint32_t links = 0;
    add_link(r, links, r.corner[3 * start], { start, r.corner[3 * start + 1], r.corner[3 * start + 2] });
    for (uint32_t i = 0; i < links && links < all; i++) {
        const uint32_t u = r.slot_of[i];
        walk_place at = { r.begin[i], r.p[i], r.q[i] };
        if (!walk_around(r, links, u, at)) {
            uint32_t next;                           /* back to the hull at the other end, then again from there */
            while ((next = across(r, at.simplex, at.q)) != (INDEX)~0u) {
                at = { next, third(r, next, u, at.p), at.p };
            }
            add_link(r, links, at.p, { at.simplex, at.q, u });
            walk_around(r, links, u, at);
        }
    }
    r.total[links_found] = links;
}

/* Sets a corner to the centre of a simplex of the star, from v; returns its flags. */
template <typename INDEX>
DEVICE unsigned place_centre(const diagram &d, const cell_room<INDEX> &r, uint32_t v, uint32_t place, uint32_t corner)
{
    const double *a = d.points + 3 * (size_t)d.simplices[4 * (size_t)r.simplex[place]];
    real centre[3];
    const unsigned flags = centre_of<3>(d, r.simplex[place], centre);
    for (int k = 0; k < 3; k++) {
        r.x[3 * corner + k] = centre[k] + (real(a[k]) - d.points[3 * (size_t)v + (size_t)k]);
    }
    return flags;
}

/* The polytope of a closed star: its loops, corners in the order of their first use.  Returns the flags of all
   centres. */
template <typename INDEX>
DEVICE unsigned star_polytope(const diagram &d, const cell_room<INDEX> &r, uint32_t v, uint32_t links, counts &n)
{
    const loops_of<INDEX> &loops = r.now;
    const uint32_t simplices = n.corners;
    unsigned flags = good_centre | inside_box;
    n.facets = links;
    n.entries = warp_sum_before(links, [&](uint32_t i) { return r.size_of_ring[r.slot_of[i]]; },
                                [&](uint32_t i, uint32_t before) { loops.start[i] = (INDEX)before; });
    warp_once([&]() { loops.start[links] = (INDEX)n.entries; });
    warp_each(links, [&](uint32_t i) {
        walk_place at = { r.begin[i], r.p[i], r.q[i] };
        loops.name[i] = (INDEX)i;
        for (uint32_t e = loops.start[i]; e < loops.start[i + 1]; e++) {
            loops.corner[e] = (INDEX)at.simplex;
            loops.facet[e] = (INDEX)i;
            min_at(r.first_use + at.simplex, e);
            const uint32_t next = across(r, at.simplex, at.p);
            at = { next, at.q, third(r, next, r.slot_of[i], at.q) };
        }
    });
    warp_number(n.entries, [&](uint32_t e) { return r.first_use[loops.corner[e]] == e ? 1u : 0u; },
                [&](uint32_t e, unsigned first, uint32_t before, uint32_t) {
        if (first != 0) {
            r.corner_of[loops.corner[e]] = (INDEX)before;
        }
    });
    warp_each(simplices, [&](uint32_t i) { flags &= place_centre(d, r, v, i, r.corner_of[i]); });
    warp_each(n.entries, [&](uint32_t e) { loops.corner[e] = r.corner_of[loops.corner[e]]; });
    return (any((flags & good_centre) == 0) ? 0 : good_centre) | (any((flags & inside_box) == 0) ? 0 : inside_box);
}

/* From the site to a vertex, and where the plane between their cells is along that.  Returns the squared length. */
DEVICE real to_vertex(const diagram &d, uint32_t v, uint32_t vertex, real *to, real &foot)
{
    real square = 0.0;
    for (int k = 0; k < 3; k++) {
        to[k] = real(d.points[3 * (size_t)vertex + (size_t)k]) - d.points[3 * (size_t)v + (size_t)k];
        square += to[k] * to[k];
    }
    foot = 0.5;
    if (d.weights != NULL) {
        foot += (real(d.weights[v]) - d.weights[vertex]) / (real(2.0) * square);
    }
    return square;
}

template <typename INDEX>
DEVICE real to_link(const diagram &d, const cell_room<INDEX> &r, uint32_t v, uint32_t link, real *to, real &foot)
{
    return to_vertex(d, v, r.key[r.slot_of[link]], to, foot);
}

/* What the edges of a ring of centres add up to; foot: where its plane is along `to`. */
struct ring_sums {
    real along, moment[3];
    DEVICE ring_sums() : along(0.0), moment{ 0.0, 0.0, 0.0 } {}
    DEVICE void add(const real *to, const real *s, const real *t)
    {
        real across[3];
        cross(s, t, across);
        const real w = dot(to, across);
        along += w;
        for (int k = 0; k < 3; k++) {
            moment[k] += w * (s[k] + t[k]);
        }
    }
    DEVICE void set_term(const real *to, real foot, real *term) const
    {
        for (int k = 0; k < 3; k++) {
            term[k] = foot * (moment[k] + along * (foot * to[k]));
        }
        term[3] = foot * along;
    }
};

/* The sums of a cell that is not cut, from the polytope of its star: ring by ring. */
template <typename INDEX>
DEVICE void sum_rings(const diagram &d, const cell_room<INDEX> &r, uint32_t v, const counts &n, real *sum)
{
    warp_add_in_order(n.facets, r.side, [&](uint32_t i, real *term) {
        real to[3], foot;
        ring_sums ring;
        to_link(d, r, v, i, to, foot);
        for (uint32_t e = r.now.start[i]; e < r.now.start[i + 1]; e++) {
            ring.add(to, r.x + 3 * (size_t)r.now.corner[e], r.x + 3 * (size_t)follower(r.now, e));
        }
        ring.set_term(to, foot, term);
    }, sum);
}

/* Cuts the polytope of the star by the walls of the box. */
template <typename INDEX> DEVICE bool cut_by_box(const diagram &d, cell_room<INDEX> &r, uint32_t v, counts &n)
{
    bool fits = true;
    for (uint32_t i = 0; i < 6 && fits; i++) {
        const real site = d.points[3 * (size_t)v + i / 2];
        const real plane[3] = { i / 2 == 0 ? i % 2 * 2.0 - 1.0 : 0.0, i / 2 == 1 ? i % 2 * 2.0 - 1.0 : 0.0,
                                i / 2 == 2 ? i % 2 * 2.0 - 1.0 : 0.0 };
        fits = cut_polytope(r, n, plane, i % 2 != 0 ? real(d.high[i / 2]) - site : site - d.low[i / 2], ~i);
    }
    return fits;
}

/* Cuts the box by the planes between v and all links. */
template <typename INDEX>
DEVICE bool cut_box(const diagram &d, cell_room<INDEX> &r, uint32_t v, uint32_t links, counts &n)
{
    const char *const face = "046213750154267302314576";             /* corners, four a wall */
    bool fits = true;
    n = { 8, 6, 24 };
    warp_each(8, [&](uint32_t i) {
        for (uint32_t k = 0; k < 3; k++) {
            r.x[3 * i + k] = box_corner<3>(d, v, (int)k, (i >> k & 1) != 0);
        }
    });
    warp_each(24, [&](uint32_t i) {
        r.now.corner[i] = (INDEX)(face[i] - '0');
        r.now.facet[i] = (INDEX)(i / 4);
        r.now.name[i / 4] = (INDEX)~(i / 4);
        r.now.start[i / 4 + 1] = (INDEX)(i / 4 * 4 + 4);
        r.now.start[0] = 0;
    });
    for (uint32_t i = 0; i < links && fits; i++) {
        real to[3], foot;
        const real square = to_link(d, r, v, i, to, foot);
        fits = cut_polytope(r, n, to, foot * square, i);
    }
    return fits;
}

/* The edge between two corners of a simplex. */
DEVICE uint32_t edge_between(uint32_t i, uint32_t j)
{
    return i == 0 ? j - 1 : j == 0 ? i - 1 : i + j;
}

/* Adds the values of all lanes with one slot, in the order of the lanes, to the number of the slot; at(slot): where
   that is.  slot: none for a lane without a value. */
template <typename F> DEVICE void add_by_slots(uint32_t slot, real value, F at)
{
    const unsigned peers = __match_any_sync(all_lanes, slot);
    const bool leads = slot != none && (peers & lanes_below<32>()) == 0;
    real sum = leads ? real(*at(slot)) : real(0.0);
    unsigned rest = leads ? peers : 0;
    while (any(rest != 0)) {
        const real next = __shfl_sync(all_lanes, value.value, rest != 0 ? __ffs(rest) - 1 : 0);
        sum = rest != 0 ? sum + next : sum;
        rest &= rest - 1;
    }
    if (leads) {
        *at(slot) = sum.value;
    }
    __syncwarp();
}

/* Facets of a cell that the box does not cut, in the order of the entries that have their links first.  The areas of
   open ones are infinite. */
template <typename INDEX>
DEVICE void take_star(const cell_room<INDEX> &r, const facet_lists &lists, uint32_t v, const uint32_t *entry,
                      uint32_t count)
{
    uint32_t *const neighbor = lists.neighbor + lists.begin[v], *const first = r.size_of_ring;
    double *const area = lists.area + lists.begin[v];
    warp_each(r.size.slots, [&](uint32_t i) { first[i] = none; });
    warp_each(3 * count, [&](uint32_t e) { min_at(first + r.corner[e], e); });
    const uint32_t links = warp_number(3 * count, [&](uint32_t e) { return first[r.corner[e]] == e ? 1u : 0u; },
                                       [&](uint32_t e, unsigned is_first, uint32_t before, uint32_t) {
        if (is_first != 0) {
            r.link_of[r.corner[e]] = (INDEX)before;
            neighbor[before] = r.key[r.corner[e]];
            area[before] = 0.0;
        }
    }).x;
    for (uint32_t from = 0; from < 3 * count; from += 32) {
        const uint32_t e = from + (threadIdx.x & 31), place = e / 3;
        uint32_t slot = none;
        real part = 0.0;
        if (e < 3 * count) {
            slot = r.corner[e];
            part = lists.part[r.simplex[place]].at[edge_between(entry[place] & 3,
                                                                other_corner(entry[place] & 3, e % 3))];
        }
        add_by_slots(slot, part, [&](uint32_t at) { return area + r.link_of[at]; });
    }
    warp_each(3 * count, [&](uint32_t e) {           /* across from the others the ring of a link goes on */
        const INDEX *next = r.across + e / 3 * 3;
        if (next[(e + 1) % 3] == (INDEX)~0u || next[(e + 2) % 3] == (INDEX)~0u) {
            area[r.link_of[r.corner[e]]] = HUGE_VAL;
        }
    });
    warp_once([&]() { lists.first[v] = links; });
}

/* The area of a facet of a polytope. */
template <typename INDEX> DEVICE real facet_area(const cell_room<INDEX> &r, uint32_t facet)
{
    const uint32_t start = r.now.start[facet], end = r.now.start[facet + 1];
    const real *a = r.x + 3 * (size_t)r.now.corner[start];
    real area[3] = { 0.0, 0.0, 0.0 }, p[3], q[3], sides[3];
    for (uint32_t e = start + 1; e + 1 < end; e++) {
        const real *b = r.x + 3 * (size_t)r.now.corner[e], *c = r.x + 3 * (size_t)r.now.corner[e + 1];
        for (int k = 0; k < 3; k++) {
            p[k] = b[k] - a[k];
            q[k] = c[k] - a[k];
        }
        cross(p, q, sides);
        for (int k = 0; k < 3; k++) {
            area[k] += sides[k];
        }
    }
    return real(0.5) * root_of(dot(area, area));
}

/* Facets of a polytope: of those in a row that rounding has bent apart one, with the sum of their areas. */
template <typename INDEX>
DEVICE void take_facets(const cell_room<INDEX> &r, const facet_lists &lists, uint32_t v, uint32_t facets)
{
    const uint32_t links = r.total[links_found];
    const INDEX *name = r.now.name;
    const uint2 found = warp_number(facets, [&](uint32_t i) { return i == 0 || name[i] != name[i - 1] ? 1u : 0u; },
                                    [&](uint32_t i, unsigned first, uint32_t before, uint32_t) {
        if (first != 0) {
            real area = facet_area(r, i);
            for (uint32_t next = i + 1; next < facets && name[next] == name[i]; next++) {
                area += facet_area(r, next);
            }
            lists.neighbor[lists.begin[v] + before] = name[i] < links ? r.key[r.slot_of[name[i]]]
                                                    : none - 1 - (uint32_t)(INDEX)~name[i];
            lists.area[lists.begin[v] + before] = area.value;
        }
    });
    warp_once([&]() { lists.first[v] = found.x; });
}

/* The cell that the box cuts out.  Returns false if the room is too small. */
template <typename INDEX>
DEVICE bool cut_cell(const diagram &d, cell_room<INDEX> &r, const facet_lists &lists, uint32_t v, bool is_far,
                     counts n)
{
    real sum[4] = { 0.0, 0.0, 0.0, 0.0 };
    if (!(is_far ? cut_box(d, r, v, r.total[links_found], n) : cut_by_box(d, r, v, n))) {
        return false;
    }
    sum_polytope(r, n, sum);
    warp_once([&]() { set_cell<3>(d, v, sum); });
    if (d.padded.is_cut != NULL) {
        d.padded.is_cut[v] = 1;
        warp_each(n.entries, [&](uint32_t e) { hold_corner<3>(d, v, r.x + 3 * (size_t)r.now.corner[e]); });
    }
    if (lists.first != NULL) {                       /* of no volume: the box at most touches the cell */
        take_facets(r, lists, v, sum[3] > 0.0 ? n.facets : 0);
    }
    return true;
}

/* The cell of v from its star.  Returns false if the room is too small. */
template <typename INDEX>
DEVICE bool star_cell(const diagram &d, cell_room<INDEX> &r, const facet_lists &lists, uint32_t v,
                      const uint32_t *entry, uint32_t count)
{
    counts n = { count, 0, 0 };
    if (count > r.size.simplices || count > r.size.corners) {
        return false;
    }
    const bool open = fetch_star(d, r, entry, count);
    const uint32_t links = warp_number(r.size.slots, [&](uint32_t i) { return r.key[i] != none ? 1u : 0u; },
                                       [](uint32_t, unsigned, uint32_t, uint32_t) {}).x;
    if (links > r.size.links || 3 * count > r.size.entries || links > r.size.facets) {
        return false;
    }
    if (lists.first != NULL && lists.is_left[v] == 0) {          /* too large for the kernel of facets */
        take_star(r, lists, v, entry, count);
        return true;
    }
    if (open && !d.bounded) {
        warp_once([&]() { set_unbounded<3>(d, v); });
        if (lists.first != NULL) {
            take_star(r, lists, v, entry, count);
        }
        return true;
    }
    warp_once([&]() { find_links(r, place_of(r.simplex, count, d.incident[v]), links); });
    const unsigned flags = open ? 0 : star_polytope(d, r, v, links, n);
    if (!open && (!d.bounded || (flags & inside_box) != 0)) {
        real sum[4] = { 0.0, 0.0, 0.0, 0.0 };
        sum_rings(d, r, v, n, sum);
        warp_once([&]() { set_cell<3>(d, v, sum); });
        if (lists.first != NULL) {
            take_star(r, lists, v, entry, count);
        }
        return true;
    }
    bool is_far = open || (flags & good_centre) == 0;
    warp_each(open ? 0 : 3 * n.corners, [&](uint32_t i) {
        is_far = is_far || !(size_of(r.x[i]) < real(4.0) * d.extent[i % 3]);
    });
    return cut_cell(d, r, lists, v, any(is_far), n);
}

/* What a rung of stars reads and leaves. */
struct star_rung {
    stars at;
    queue todo, left;                                /* left: those that the room is too small for */
    uint32_t *next;                                  /* the first of todo that no warp has taken */
    room_sizes size;                                 /* of large rooms */
    char *memory;                                    /* for these */
};

/* Rooms: small and middle ones in shared memory, of constant sizes; large ones. */
template <typename INDEX> HOST_DEVICE constexpr room_sizes size_of_room(const room_sizes &large)
{
    return sizeof(INDEX) == 1 ? room_sizes{ 72, 46, 128, 128, 240, 64, 64 }
         : sizeof(INDEX) == 2 ? room_sizes{ 160, 100, 256, 320, 700, 130, 128 } : large;
}

template <typename INDEX> struct rung_shape {
    enum { warps = sizeof(INDEX) == 1 ? 4 : sizeof(INDEX) == 2 ? 2 : 1, blocks = sizeof(INDEX) == 1 ? 6 : 4 };
};

template <typename INDEX> __global__ void __launch_bounds__(32 * rung_shape<INDEX>::warps, rung_shape<INDEX>::blocks)
star_kernel(const diagram d, const facet_lists lists, const star_rung a)
{
    extern __shared__ __align__(16) char shared[];
    const uint32_t count = *a.todo.count;
    const room_sizes size = size_of_room<INDEX>(a.size);
    cell_room<INDEX> room;
    const size_t bytes = lay_out<INDEX>(size, NULL, room);
    lay_out(size, sizeof(INDEX) == 4 ? a.memory + thread_number() / 32 * bytes : shared + threadIdx.x / 32 * bytes,
            room);
    while (true) {
        uint32_t i = 0;
        if ((threadIdx.x & 31) == 0) {
            i = atomicAdd(a.next, 1u);
        }
        i = __shfl_sync(all_lanes, i, 0);
        if (i >= count) {
            break;
        }
        const uint32_t v = a.todo.vertex[i], first = a.at.first[v];
        if (!star_cell<INDEX>(d, room, lists, v, a.at.entry + first, a.at.first[v + 1] - first)
            && (threadIdx.x & 31) == 0) {
            a.left.vertex[atomicAdd(a.left.count, 1u)] = v;
        }
        __syncwarp();
    }
}

/* Facets of a cell that the box does not cut, by 16 lanes: most cells.  As take_star has them. */
const uint32_t facet_lanes = 16, facet_simplices = 64, facet_slots = 64;

struct facet_room {
    real part[facet_simplices][3];                   /* per simplex and corner */
    uint32_t key[facet_slots], at[facet_slots][2];   /* vertices of links; a bit for each simplex that has one */
    uint32_t slots[facet_simplices];                 /* of the corners of a simplex: bytes */
    uint8_t slot_of[facet_slots];                    /* of each link, in their order */
};

DEVICE unsigned facet_mask()
{
    return 0xffffu << (threadIdx.x & 16);
}

DEVICE void fetch_facets(const diagram &d, const facet_lists &lists, facet_room &r, const uint32_t *entry,
                         uint32_t count)
{
    const uint32_t lane = threadIdx.x % facet_lanes;
    for (uint32_t i = lane; i < facet_slots; i += facet_lanes) {
        r.key[i] = none;
        r.at[i][0] = r.at[i][1] = 0;
    }
    __syncwarp(facet_mask());
    for (uint32_t i = lane; i < count; i += facet_lanes) {
        const uint32_t simplex = entry[i] >> 2, corner = entry[i] & 3;
        uint32_t slots = 0;
        for (uint32_t k = 0; k < 3; k++) {
            const uint32_t other = other_corner(corner, k);
            const uint32_t slot = slot_of(r.key, facet_slots, d.simplices[4 * (size_t)simplex + other]);
            atomicOr(&r.at[slot][i / 32], 1u << i % 32);
            r.part[i][k] = lists.part[simplex].at[edge_between(corner, other)];
            slots |= slot << 8 * k;
        }
        r.slots[i] = slots;
    }
    __syncwarp(facet_mask());
}

/* Lists the links in the order of their first entries. */
DEVICE void order_facets(facet_room &r, uint32_t count)
{
    const uint32_t lane = threadIdx.x % facet_lanes, shift = threadIdx.x & 16;
    uint32_t links = 0;
    for (uint32_t from = 0; from < count; from += facet_lanes) {
        const uint32_t i = from + lane, slots = i < count ? r.slots[i] : 0;
        unsigned first[3], before = 0, all = 0;
        for (int k = 0; k < 3; k++) {
            const uint32_t *at = r.at[slots >> 8 * k & 255];
            const uint32_t lowest = at[0] != 0 ? __ffs(at[0]) - 1 : 31 + __ffs(at[1]);
            first[k] = __ballot_sync(facet_mask(), i < count && lowest == i) >> shift & 0xffff;
            before += __popc(first[k] & ((1u << lane) - 1));
            all += __popc(first[k]);
        }
        for (int k = 0; k < 3; k++) {
            if ((first[k] >> lane & 1) != 0) {
                r.slot_of[links + before++] = (uint8_t)(slots >> 8 * k);
            }
        }
        links += all;
    }
    __syncwarp(facet_mask());
}

/* The area of the facet of the link at a slot. */
DEVICE real sum_facet(const facet_room &r, uint32_t slot)
{
    real area = 0.0;
    for (uint32_t half = 0; half < 2; half++) {
        for (uint32_t rest = r.at[slot][half]; rest != 0; rest &= rest - 1) {
            const uint32_t i = 32 * half + (uint32_t)__ffs(rest) - 1, slots = r.slots[i];
            area += r.part[i][(slots >> 8 & 255) == slot ? 1 : slots >> 16 == slot ? 2 : 0];
        }
    }
    return area;
}

/* The facets of the listed vertices; those of cells that are left, and of large stars, are copied from `made`. */
__global__ void __launch_bounds__(128)
facet_kernel(const diagram d, const facet_lists made, const facet_lists lists, const stars s, const queue todo)
{
    __shared__ facet_room rooms[128 / facet_lanes];
    facet_room &r = rooms[threadIdx.x / facet_lanes];
    const size_t item = thread_number() / facet_lanes;
    if (item >= *todo.count) {
        return;
    }
    const uint32_t lane = threadIdx.x % facet_lanes, v = todo.vertex[item], entries = s.first[v];
    const uint32_t count = s.first[v + 1] - entries, links = (uint32_t)(lists.first[v + 1] - lists.first[v]);
    uint32_t *const neighbor = lists.neighbor + lists.first[v];
    double *const area = lists.area + lists.first[v];
    if (made.is_left[v] != 0 || count > facet_simplices) {
        for (uint32_t i = lane; i < links; i += facet_lanes) {
            neighbor[i] = made.neighbor[made.begin[v] + i];
            area[i] = made.area[made.begin[v] + i];
        }
        return;
    }
    fetch_facets(d, made, r, s.entry + entries, count);
    order_facets(r, count);
    for (uint32_t i = lane; i < links; i += facet_lanes) {
        neighbor[i] = r.key[r.slot_of[i]];
        area[i] = sum_facet(r, r.slot_of[i]).value;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>polygons     Cells in the plane, by a thread each.
   In: a mesh, a box.  Out: areas, centroids, edges of cells.
   Holds: parts and links are in the order of >>stars of pbw_cells.h, and so are the corners of polygons that are cut.
   ------------------------------------------------------------------------------------------------------ */
/* A triangle at a vertex, which is its corner `place`. */
struct part {
    uint32_t simplex, place;
};

DEVICE part part_of(const diagram &d, uint32_t simplex, uint32_t v)
{
    const uint32_t *corner = d.simplices + 3 * (size_t)simplex;
    return { simplex, (uint32_t)(corner[1] == v) + 2 * (uint32_t)(corner[2] == v) };
}

DEVICE uint32_t at_corner(const uint32_t *array, const part &p, uint32_t after)
{
    return array[3 * (size_t)p.simplex + (p.place + after) % 3];
}

/* The centre of a part, from v.  Returns its flags. */
DEVICE unsigned centre_from(const diagram &d, uint32_t v, uint32_t simplex, real *x)
{
    const size_t a = 2 * (size_t)d.simplices[3 * (size_t)simplex];
    const unsigned flags = centre_of<2>(d, simplex, x);
    for (size_t k = 0; k < 2; k++) {
        x[k] = x[k] + (coordinate(d, a + k) - coordinate(d, 2 * (size_t)v + k));
    }
    return flags;
}

/* Calls f(part) for all parts of v, counter-clockwise, from its incident simplex or, at the hull, from there; before
   the first one restart().  Returns whether v is at the hull: then there may have been two rounds. */
template <typename F, typename R> DEVICE bool visit_parts(const diagram &d, uint32_t v, R restart, F f)
{
    uint32_t first = d.incident[v], next = none;
    for (int round = 0; round < 2 && next == none; round++) {
        uint32_t at = first, back;
        restart();
        do {
            const part p = part_of(d, at, v);
            f(p);
            at = next = at_corner(d.neighbors, p, 1);
        } while (at != none && at != first);
        while (round == 0 && next == none
               && (back = at_corner(d.neighbors, part_of(d, first, v), 2)) != none) {
            first = back;
        }
    }
    return next == none;
}

/* From v to a link.  Returns the squared length. */
DEVICE real to_link(const diagram &d, uint32_t v, uint32_t link, real *to)
{
    real square = 0.0;
    for (size_t k = 0; k < 2; k++) {
        to[k] = coordinate(d, 2 * (size_t)link + k) - coordinate(d, 2 * (size_t)v + k);
        square += to[k] * to[k];
    }
    return square;
}

/* A facet of a cell that is not cut, from s to t. */
DEVICE void take_edge(const diagram &d, facet_writer &out, uint32_t v, uint32_t link, const real *s, const real *t)
{
    real to[2];
    const real square = to_link(d, v, link, to), x = t[0] - s[0], y = t[1] - s[1];
    out.take(link, (to[0] * y - to[1] * x) / root_of(square));
}

/* The cell of v, unless it is left: then returns false. */
DEVICE bool plane_cell(const diagram &d, const facet_lists &lists, uint32_t v)
{
    real first[2], last[2] = { 0.0, 0.0 }, sum[4];
    uint32_t link = none;                            /* between the last part and the next */
    unsigned flags = 0;
    facet_writer out(lists, v);
    auto add = [&](const real *t) {
        const real w = last[0] * t[1] - last[1] * t[0];
        sum[0] += w * (last[0] + t[0]);
        sum[1] += w * (last[1] + t[1]);
        sum[3] += w;
        if (lists.first != NULL) {
            take_edge(d, out, v, link, last, t);
        }
    };
    const bool open = visit_parts(d, v, [&]() {
        flags = good_centre | inside_box;
        sum[0] = sum[1] = sum[2] = sum[3] = 0.0;
        out.count = 0;
        link = none;
    }, [&](const part &p) {
        real t[2];
        flags &= centre_from(d, v, p.simplex, t);
        if (link != none) {
            add(t);
        } else {
            first[0] = t[0];
            first[1] = t[1];
            if (out.count == 0 && at_corner(d.neighbors, p, 2) == none) {
                out.take(at_corner(d.simplices, p, 1), HUGE_VAL);
            }
        }
        link = at_corner(d.simplices, p, 2);
        last[0] = t[0];
        last[1] = t[1];
    });
    if (d.bounded && (open || (flags & inside_box) == 0)) {
        return false;
    }
    if (open) {
        out.take(link, HUGE_VAL);
        set_unbounded<2>(d, v);
    } else {
        add(first);
        set_cell<2>(d, v, sum);
    }
    out.set_count(v);
    return true;
}

/* A polygon in the memory of a thread: corners, of those that cuts made the cut edges; the loop, and the edge after
   each of its corners. */
struct polygon {
    uint32_t size, corners, length;                  /* length: above size if it is too small */
    real *x, *side;
    uint32_t *low, *high, *loop, *name, *next_loop, *next_name;
};

HOST_DEVICE size_t polygon_bytes(uint32_t size)
{
    return (size_t)size * (3 * sizeof(real) + 6 * sizeof(uint32_t));
}

DEVICE polygon polygon_in(char *memory, uint32_t size)
{
    real *const x = (real *)memory;
    uint32_t *const word = (uint32_t *)(x + 3 * (size_t)size);
    return { size, 0, 0, x, x + 2 * (size_t)size, word, word + size, word + 2 * (size_t)size,
             word + 3 * (size_t)size, word + 4 * (size_t)size, word + 5 * (size_t)size };
}

DEVICE void add_corner(polygon &p, real x, real y, uint32_t edge)
{
    if (p.corners < p.size) {
        p.x[2 * p.corners] = x;
        p.x[2 * p.corners + 1] = y;
        p.loop[p.corners] = p.corners;
        p.name[p.corners] = edge;
    }
    p.length = ++p.corners;
}

/* The corner on the edge between two others, made at its first use, or p.size if there is no room; old: the corners
   before this cut. */
DEVICE uint32_t cut_edge(polygon &p, uint32_t from, uint32_t to, uint32_t old)
{
    const uint32_t low = from < to ? from : to, high = from < to ? to : from;
    for (uint32_t i = p.corners; i-- > old; ) {
        if (p.low[i] == low && p.high[i] == high) {
            return i;
        }
    }
    if (p.corners < p.size) {
        const real t = p.side[low] / (p.side[low] - p.side[high]);
        for (uint32_t k = 0; k < 2; k++) {
            const real a = p.x[2 * low + k], b = p.x[2 * high + k];
            p.x[2 * p.corners + k] = a + t * (b - a);
        }
        p.low[p.corners] = low;
        p.high[p.corners] = high;
        return p.corners++;
    }
    return p.size;
}

/* Keeps the part with plane.x <= c.  Returns whether the room is large enough. */
DEVICE bool cut_polygon(polygon &p, const real *plane, real c, uint32_t name)
{
    const real tiny = 2.3e-308;
    const uint32_t old = p.corners;
    uint32_t length = 0;
    bool outside = false, fits = true;
    for (uint32_t i = 0; i < old; i++) {
        const real s = plane[0] * p.x[2 * i] + plane[1] * p.x[2 * i + 1] - c;
        p.side[i] = s < 0.0 || s > 0.0 ? s : -tiny;
        outside = outside || s > 0.0;
    }
    auto take = [&](uint32_t corner, uint32_t edge) {
        fits = fits && length < p.size && corner < p.size;
        if (fits) {
            p.next_loop[length] = corner;
            p.next_name[length++] = edge;
        }
    };
    for (uint32_t i = 0; i < p.length && outside; i++) {
        const uint32_t a = p.loop[i], b = p.loop[i + 1 < p.length ? i + 1 : 0], edge = p.name[i];
        const bool in = p.side[a] < 0.0, leaves = p.side[b] > 0.0;
        if (!(p.side[a] > 0.0)) {
            take(a, edge);
        }
        if (in ? leaves : p.side[b] < 0.0) {
            take(cut_edge(p, a, b, old), leaves ? name : edge);
        }
    }
    if (outside) {
        exchange(p.loop, p.next_loop);
        exchange(p.name, p.next_name);
        p.length = length;
    }
    return fits;
}

DEVICE bool cut_by_box(const diagram &d, polygon &p, uint32_t v)
{
    bool fits = p.length <= p.size;
    for (uint32_t i = 0; i < 4 && fits; i++) {
        const real site = d.points[2 * (size_t)v + i / 2];
        const real plane[2] = { i / 2 == 0 ? i % 2 * 2.0 - 1.0 : 0.0, i / 2 == 1 ? i % 2 * 2.0 - 1.0 : 0.0 };
        fits = cut_polygon(p, plane, i % 2 != 0 ? real(d.high[i / 2]) - site : site - d.low[i / 2], none - 1 - i);
    }
    return fits;
}

/* The box, cut by the planes between v and all links. */
DEVICE bool cut_box(const diagram &d, polygon &p, uint32_t v)
{
    uint32_t links = 0;
    bool fits = true;
    auto cut = [&](uint32_t link) {
        real to[2], foot = 0.5;
        const real square = to_link(d, v, link, to);
        if (d.weights != NULL) {
            foot += (real(d.weights[v]) - d.weights[link]) / (real(2.0) * square);
        }
        fits = fits && cut_polygon(p, to, foot * square, link);
    };
    visit_parts(d, v, [&]() {
        const uint32_t wall[4] = { 2, 1, 3, 0 };
        p.corners = 0;
        links = 0;
        for (int i = 0; i < 4; i++) {                /* their numbers are in binary order: exchanged below */
            const bool right = i == 1 || i == 3, top = i > 1;
            add_corner(p, box_corner<2>(d, v, 0, right), box_corner<2>(d, v, 1, top), none - 1 - wall[i]);
        }
        p.loop[2] = 3;
        p.loop[3] = 2;
        fits = true;
    }, [&](const part &at) {
        if (links++ == 0 && at_corner(d.neighbors, at, 2) == none) {
            cut(at_corner(d.simplices, at, 1));
        }
        cut(at_corner(d.simplices, at, 2));
    });
    return fits;
}

/* The cell of v, cut by the box.  Returns false if the room is too small. */
DEVICE bool cut_plane_cell(const diagram &d, const facet_lists &lists, uint32_t v, polygon &p)
{
    real sum[4] = { 0.0, 0.0, 0.0, 0.0 };
    unsigned flags = 0;
    bool far = false;
    const bool open = visit_parts(d, v, [&]() {
        p.corners = 0;
        flags = good_centre;
        far = false;
    }, [&](const part &at) {
        real x[2];
        flags &= centre_from(d, v, at.simplex, x);
        far = far || !(size_of(x[0]) < real(4.0) * d.extent[0]) || !(size_of(x[1]) < real(4.0) * d.extent[1]);
        add_corner(p, x[0], x[1], at_corner(d.simplices, at, 2));
    });
    if (!(open || far || flags == 0 ? cut_box(d, p, v) : cut_by_box(d, p, v))) {
        return false;
    }
    if (d.padded.is_cut != NULL) {
        d.padded.is_cut[v] = 1;
    }
    facet_writer out(lists, v);
    for (uint32_t i = 0; i < p.length; i++) {
        const real *a = p.x + 2 * p.loop[i], *b = p.x + 2 * p.loop[i + 1 < p.length ? i + 1 : 0];
        const real w = a[0] * b[1] - a[1] * b[0];
        sum[3] += w;
        sum[0] += w * (a[0] + b[0]);
        sum[1] += w * (a[1] + b[1]);
        if (d.padded.is_cut != NULL) {
            hold_corner<2>(d, v, a);
        }
        if (lists.first != NULL) {
            out.take(p.name[i], root_of((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1])));
        }
    }
    if (!(sum[3] > 0.0)) {                           /* the box at most touches the cell */
        out.count = 0;
    }
    set_cell<2>(d, v, sum);
    out.set_count(v);
    return true;
}

/* Cells of all vertices of the plane, near ones together: each by a thread of its incident simplex. */
__global__ void plane_kernel(const diagram d, const facet_lists lists, const queue left)
{
    const size_t simplex = thread_number();
    for (int k = 0; k < 3 && simplex < d.simplex_count; k++) {
        const uint32_t v = d.simplices[3 * simplex + (size_t)k];
        if (has_cell(d, v) && d.incident[v] == simplex && !plane_cell(d, lists, v)) {
            left.vertex[atomicAdd(left.count, 1u)] = v;
        }
    }
}

/* The cells that are left, with room for polygons of so many corners in each thread's memory. */
__global__ void polygon_kernel(const diagram d, const facet_lists lists, const queue todo, const queue left,
                               char *memory, uint32_t size)
{
    const size_t stride = (size_t)gridDim.x * blockDim.x;
    for (size_t i = thread_number(); i < *todo.count; i += stride) {
        polygon p = polygon_in(memory + thread_number() * polygon_bytes(size), size);
        if (!cut_plane_cell(d, lists, todo.vertex[i], p)) {
            left.vertex[atomicAdd(left.count, 1u)] = todo.vertex[i];
        }
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>run          The stages in order.
   In: packed points on the device.  Out: the mesh of the call, on the device, and the times of its
   stages.
   ------------------------------------------------------------------------------------------------------ */
void open_stream(call &c, cudaStream_t &stream)
{
    need(c, cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "cudaStreamCreate");
}

/* count: the points to triangulate; 0 in a check. */
void open_call(call &c, int dim, size_t count)
{
    const int device = c.team->offers[c.card].device;
    int pools = 0;
    c.dim = dim;
    c.count = count;
    c.stars = count / (size_t)c.team->count;
    need(c, cudaDeviceGetAttribute(&pools, cudaDevAttrMemoryPoolsSupported, device), "cudaDeviceGetAttribute");
    require(c, pools != 0, PBW_ERROR_BACKEND, "the device or its driver has no memory pools");
    if (!c.borrowed) {
        need(c, cudaDeviceGetMemPool(&c.pool, device), "cudaDeviceGetMemPool");
        for (int i = 0; i < 10; i++) {
            need(c, i < 8 ? cudaEventCreate(&c.mark[i])
                          : cudaEventCreateWithFlags(&c.ready[i - 8], cudaEventDisableTiming), "cudaEventCreate");
        }
    }
}

/* Destroys the events and the stream of copies; those that were not made are NULL. */
void destroy(const call_resources &g)
{
    for (int i = 0; i < 10; i++) {
        const cudaEvent_t event = i < 8 ? g.mark[i] : g.ready[i - 8];
        if (event != NULL) {
            cudaEventDestroy(event);
        }
    }
    if (g.copies != NULL) {
        cudaStreamDestroy(g.copies);
    }
}

/* Frees all blocks; the stream may still have work for them. */
void close_call(call &c)
{
    while (c.blocks > 0) {
        release(c, c.block[0].address);
    }
    if (!c.borrowed) {
        destroy(c);
    }
    (void)cudaGetLastError();
}

const uint32_t sphere_sample = 256;
const int sphere_fits = 8;

/* Sets `off` to how far points of a sample are from a sphere of four of them, in parts of its radius: of several such
   spheres the nearest, but none that is much larger than the sample.  By a block of sphere_sample threads. */
__global__ void sphere_kernel(const input in, float *off)
{
    __shared__ double x[sphere_sample][4];
    __shared__ int most;
    const size_t i = threadIdx.x;
    double extent = 0.0;
    float least = 1.0f;
    fetch(in, i * (in.count / sphere_sample), x[i]);
    __syncthreads();
    for (int k = 0; k < 3; k++) {
        double low = x[0][k], high = low;
        for (uint32_t j = 1; j < sphere_sample; j++) {
            low = fmin(low, x[j][k]);
            high = fmax(high, x[j][k]);
        }
        extent = fmax(extent, high - low);
    }
    for (int fit = 0; fit < sphere_fits; fit++) {
        double row[3][3], half[3], normal[3][3], centre[3], square = 0.0, from = 0.0;
        if (i == 0) {
            most = 0;
        }
        __syncthreads();
        for (int k = 0; k < 9; k++) {
            row[k / 3][k % 3] = x[(k / 3 + 1) * (int)sphere_sample / 4 + fit][k % 3] - x[fit][k % 3];
        }
        for (int j = 0; j < 3; j++) {
            half[j] = 0.5 * product(row[j], row[j]);
            cross(row[(j + 1) % 3], row[(j + 2) % 3], normal[j]);
        }
        for (int k = 0; k < 3; k++) {
            centre[k] = (half[0] * normal[0][k] + half[1] * normal[1][k] + half[2] * normal[2][k])
                      / product(row[0], normal[0]);
            const double to = x[i][k] - x[fit][k] - centre[k];
            square += centre[k] * centre[k];
            from += to * to;
        }
        const float part = (float)(fabs(sqrt(from) - sqrt(square)) / sqrt(square));
        atomicMax(&most, __float_as_int(part < 1.0f && extent > 1.5 * sqrt(square) ? part : 1.0f));
        __syncthreads();
        least = fminf(least, __int_as_float(most));
        __syncthreads();
    }
    if (i == 0) {
        *off = least;
    }
}

/* Leaves points on a sphere, or in a shell around an empty ball, to the CPU.  n points on a sphere leave gaps of some
   4 pi R^2 / n; there it is pi R / 2 n higher than a plane, and if they are nearer to it than a part of that, most
   are in doubt of being in the sphere of a simplex.  In a shell the points at the ball see each other across it, and
   many have stars that are too large for all rungs but the last: measured, too many (far_limit) from 200,000 points
   on, in shells of up to a tenth of the radius on either side.  This test takes 0.1 ms; to build them in vain takes
   30 to 400 ms. */
void decline_spheres(call &c, const input &in)
{
    const double limit = in.count < 150000 ? 0.05 * 1.57 / (double)in.count : 0.16;
    buffer<float> off(c, 1);
    launch(c, "sphere", sphere_kernel, shape{ 1, sphere_sample, 0 }, in, off.at);
    decline_unless(c, read_back(c, off.at, PBW_STAGE_ORDER, 0.0) > limit,
                   "most stars reach far (points on a sphere?): quicker on the CPU");
}

void run(call &c, const input &in, unsigned flags)
{
    space s = {};
    uint32_t *id = NULL;
    c.mesh->dim = in.dim;
    c.mesh->point_count = in.count;
    decline_unless(c, in.count >= PBW_CUDA_FEW, few_points);
    decline_unless(c, in.count < (size_t)1 << 31, "too many points for the device code");
    record_mark(c, 0);
    c.mesh->canonical = allocate<pbw_index>(c, in.count);
    const bool may_decline = in.dim == 3 && in.weights == NULL && in.count >= sampled_from && !c.no_cpu
                          && !pbw_cuda_patient;
    const bool has_last = c.last != NULL && c.last->mesh.simplex_count > 0;
    if (may_decline && !has_last) {
        decline_spheres(c, in);
    }
    const bool weighted = order_points(c, in, s, id);
    release(c, in.points);                           /* those of a job: the records have all */
    release(c, in.weights);
    record_mark(c, 1);
    if (!keep_last(c, in, s, id)) {
        if (may_decline && has_last) {
            decline_spheres(c, in);
        }
        (in.dim == 3 ? (weighted ? build<3, true> : build<3, false>)
                     : (weighted ? build<2, true> : build<2, false>))(c, s, id, flags);
    }
    for (int i = 0; i < 8; i += c.mesh->kept ? 7 : 1) {
        need(c, cudaEventElapsedTime(&c.mesh->milliseconds[i], c.mark[i < 7 ? i : 0], c.mark[i < 7 ? i + 1 : 7]),
             "cudaEventElapsedTime");
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>backend      A job of pbw.h on one card or several.
   In: a job.  Out: its arrays in the memory of the host.
   Holds: no copy to the memory of the job is under way when the job ends.
   ------------------------------------------------------------------------------------------------------ */
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
    host_copy copies[2];
    bool pinned = false;
    int count = 0;
    for (; count < 2 && from[count] != NULL; count++) {
        const size_t bytes = job->count * number_size(in.is_float) * (count == 0 ? (size_t)job->dim : 1);
        char *const on_device = allocate<char>(c, bytes);
        copies[count] = { on_device, (const char *)from[count], bytes, c.ready[1] };
        (count == 0 ? in.points : in.weights) = on_device;
        pinned = pinned || is_pinned(from[count]);
    }
    need(c, cudaEventRecord(c.ready[1], c.stream), "cudaEventRecord");
    if (pinned || !copy_staged(c, copies, count, false, PBW_STAGE_ORDER)) {
        for (int i = 0; i < count; i++) {
            need(c, cudaMemcpyAsync(copies[i].to, copies[i].from, copies[i].bytes, cudaMemcpyHostToDevice, c.stream),
                 "copying points");
        }
    }
    return in;
}

/* Does the part of a card in a job. */
void run_card(card_team *team, int card, pbw_job *job, pbw_cuda_mesh *mesh)
{
    call c = call();
    c.team = team;
    c.card = card;
    c.job = job;
    c.mesh = mesh;
    try {
        need(c, cudaSetDevice(team->offers[card].device), "cudaSetDevice");
        open_stream(c, c.stream);
        open_call(c, job->dim, job->count);
        open_stream(c, c.copies);
        open_pool(c);
        run(c, upload(c), job->flags);
    } catch (const failure &) {
        report_failure(c, NULL);
    }
    if (c.copies != NULL) {                          /* they must end before the job's memory may be freed */
        wait_for_stream(c, c.copies, PBW_STAGE_OUTPUT, 0.8);
        good(c, cudaStreamSynchronize(c.copies), "copying results");
    }
    if (c.stream != NULL) {
        good(c, cudaStreamSynchronize(c.stream), "waiting for the device");
    }
    report_failure(c, NULL);
    wait_for_cards(c, true, 0.9);
    close_call(c);
    if (c.stream != NULL) {
        good(c, cudaStreamSynchronize(c.stream), "waiting for the device");
        cudaStreamDestroy(c.stream);
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
    card_team team;
    char text[128];
    team.count = list.count;
    if (job->count < PBW_CUDA_FEW) {
        job->say(job, few_points);
        job->declined = 1;
        return PBW_ERROR_BACKEND;
    }
    for (int i = 0; i < list.count; i++) {
        team.offers[i].device = list.device[i];
        if (error != cudaSuccess || list.device[i] >= devices) {
            snprintf(text, sizeof text, "device %d: %s", list.device[i],
                     error != cudaSuccess ? cudaGetErrorString(error) : "there is no such device");
            job->say(job, text);
            return PBW_ERROR_BACKEND;
        }
    }
    const pbw_status status = is_packed(job) ? PBW_OK : job->keep(job);
    if (status != PBW_OK) {
        return status;
    }
    cudaGetDevice(&before);
    try {
        for (; helpers + 1 < list.count; helpers++) {
            helper[helpers] = std::thread(run_card, &team, helpers + 1, job, &mesh[helpers + 1]);
        }
    } catch (...) {
        std::lock_guard<std::mutex> hold(team.lock);
        team.count = helpers + 1;
        team.status = PBW_ERROR_THREAD;
    }
    run_card(&team, 0, job, &mesh[0]);
    for (int i = 0; i < helpers; i++) {
        helper[i].join();
    }
    cudaSetDevice(before);
    job->duplicate_count = mesh[0].duplicate_count;
    for (int i = 0; i < list.count; i++) {
        job->hidden_count += mesh[i].hidden_count;
    }
    job->declined = team.declined;
    return (pbw_status)team.status.load();
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

namespace {
/* ------------------------------------------------------------------------------------------------------
   >>local        Points on the device: triangulate, free, check.
   In: points and weights on the current device.  Out: arrays there, or a report; after a failure nothing is left
   allocated.
   ------------------------------------------------------------------------------------------------------ */
/* A call for points on the device: a job that leaves its results there. */
struct local_call {
    call c;
    card_team alone;
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

/* A call for points on the device, as the caller wants it. */
struct request {
    input in;
    cudaStream_t stream;
    pbw_triangulator *cpu;
    pbw_cuda_mesh *mesh;                             /* what it makes; NULL: nothing */
    loop_state *last;                                /* of a loop, with its resources; else NULL */
    const call_resources *resources;
    bool rebuild, check;
    pbw_options options;
};

void open_local(local_call &local, const request &r)
{
    const pbw_options &options = r.options;
    call &c = local.c;
    local.alone.count = 1;
    pbw__context_start(&local.context, &options, r.check ? 0 : r.in.count);
    local.dispatch.context = &local.context;
    local.dispatch.options = &options;
    local.job.memory_limit = options.memory_limit;
    local.job.report = pbw__job_report;
    if (r.check) {
        local.job.report = [](pbw_job *job, pbw_stage, double done) {
            return pbw__job_report(job, PBW_STAGE_CHECK, done);
        };
    }
    local.job.say = pbw__job_say;
    local.job.context = &local.dispatch;
    c.team = &local.alone;
    c.stream = r.stream;
    c.job = &local.job;
    c.mesh = r.mesh;
    c.no_cpu = r.cpu == NULL;
    if (r.resources != NULL) {
        (call_resources &)c = *r.resources;
        c.borrowed = true;
    }
    if (r.last != NULL) {
        c.rebuild = r.rebuild;
        c.last = r.last;
        adopt_last(c);
    }
    local.fp = pbw__fp_enter();
    require(c, pbw__fp_is_exact(), PBW_ERROR_FP_MODE, pbw_status_string(PBW_ERROR_FP_MODE));
    poll(c, PBW_STAGE_ORDER, 0.0);
    throw_if_failed(c);
    need(c, cudaGetDevice(&local.alone.offers[0].device), "no usable device");
    open_call(c, r.in.dim, r.check ? 0 : r.in.count);
    if (options.progress != NULL && !c.borrowed) {
        open_stream(c, c.copies);
    }
}

/* Frees all but the arrays of the mesh, and on a failure those too. */
pbw_status close_local(local_call &local)
{
    call &c = local.c;
    pbw_cuda_mesh *const mesh = c.mesh;
    if (c.copies != NULL) {                          /* the word that stops kernels is written before it is freed */
        good(c, cudaStreamSynchronize(c.copies), "stopping");
    }
    const bool failed = c.status != PBW_OK && c.status != PBW_DEGENERATE;
    if (mesh != NULL && failed) {
        memset(mesh, 0, sizeof *mesh);               /* everything is still in the list of blocks */
    }
    if (c.last != NULL) {
        *c.last = failed ? loop_state() : loop_state{ *mesh, c.last->id, c.last->count };
        release(c, c.last->id, true);
    }
    if (mesh != NULL) {
        release_mesh(c, *mesh, true);
    }
    close_call(c);
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
void send_mesh(call &c, const pbw_mesh &host, const input &in)
{
    const pbw_index *from[mesh_arrays] = { host.simplices, host.neighbors, host.incident, host.canonical };
    *c.mesh = { in.dim, 1, in.count, host.simplex_count, host.duplicate_count, host.hidden_count };
    for (int i = 0; i < mesh_arrays; i++) {
        if (from[i] != NULL) {
            array_of(*c.mesh, i) = allocate<pbw_index>(c, entries_of(*c.mesh, i));
            need(c, cudaMemcpyAsync(array_of(*c.mesh, i), from[i], entries_of(*c.mesh, i) * sizeof(pbw_index),
                                    cudaMemcpyHostToDevice, c.stream), "copying results");
        }
    }
}

/* Builds a mesh of points on the device by the CPU: the points go to the host, the arrays to the device. */
void build_by(pbw_triangulator *cpu, call &c, const input &in, pbw_options options)
{
    pbw_memory &memory = ((pbw__dispatch *)c.job->context)->context->memory;
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
        send_mesh(c, host, in);
    } catch (const failure &) {
    }
    wait_for_stream(c, c.stream, PBW_STAGE_OUTPUT, 0.9);    /* the host arrays are freed next */
    c.status = c.status == PBW_OK ? status : c.status;
    pbw_free(&host);
    pbw__release(&memory, points, numbers, sizeof(double));
}

/* Builds a mesh, by the CPU where the device fails or declines and the caller allows it. */
pbw_status run_request(request &r, const pbw_options *given_options)
{
    const size_t size = number_size(r.in.is_float);
    pbw_status status = PBW_ERROR_BACKEND;
    if (r.mesh == NULL) {
        return PBW_ERROR_ARGUMENT;
    }
    memset(r.mesh, 0, sizeof *r.mesh);
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
        local_call local{};
        call &c = local.c;
        try {
            open_local(local, r);
            if (on_cpu) {
                build_by(r.cpu, c, r.in, r.options);
            } else {
                run(c, r.in, r.options.flags);
            }
            poll(c, PBW_STAGE_OUTPUT, 1.0);
        } catch (const failure &) {
        }
        status = close_local(local);
        if (r.cpu == NULL || (!c.declined && (r.options.flags & PBW_BACKEND_OR_CPU) == 0)) {
            break;
        }
    }
    return status;
}

} /* namespace */

extern "C" pbw_status pbw_cuda_triangulate(int dim, int is_float, const void *points, const void *weights,
                                           size_t count, const pbw_options *given_options, void *stream,
                                           pbw_triangulator *cpu, pbw_cuda_mesh *mesh)
{
    request r = { { points, weights, count, dim, is_float }, (cudaStream_t)stream, cpu, mesh };
    return run_request(r, given_options);
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
    request r = { { points, weights, 0, 0, is_float }, (cudaStream_t)stream, NULL, NULL, NULL, NULL, false, true };
    local_call local{};
    if (report != NULL) {
        memset(report, 0, sizeof *report);
        (void)pbwck__fault(report, PBWCK__SOUND, PBW_NONE, -1, PBW_NONE);
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
        poll(local.c, PBW_STAGE_CHECK, 1.0);
    } catch (const failure &) {
    }
    return close_local(local);
}

/* ------------------------------------------------------------------------------------------------------
   >>loop         Points that move.
   In: points on the device of the loop, step by step.  Out: the mesh of each step; the loop keeps it, and a pool.
   ------------------------------------------------------------------------------------------------------ */
struct pbw_cuda_loop {
    int device;
    cudaStream_t stream;
    pbw_options options;
    pbw_triangulator *cpu;
    call_resources resources;
    loop_state last;
    pbw_cuda_cells cells;
};

extern "C" pbw_status pbw_cuda_loop_create(const pbw_options *given_options, void *stream, pbw_triangulator *cpu,
                                           pbw_cuda_loop **result)
{
    request r = { { NULL, NULL, 0, 3, 0 }, (cudaStream_t)stream, cpu };
    uint64_t all = UINT64_MAX;
    cudaMemPoolProps properties = { cudaMemAllocationTypePinned, cudaMemHandleTypeNone,
                                    { cudaMemLocationTypeDevice, 0 } };
    cudaMemPool_t pool = NULL;
    local_call local{};
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
        loop = (pbw_cuda_loop *)pbw__allocate(&local.context.memory, 1, sizeof *loop);
        require(c, loop != NULL, PBW_ERROR_MEMORY, no_host_memory);
        need(c, cudaGetDevice(&properties.location.id), "cudaGetDevice");
        need(c, cudaMemPoolCreate(&pool, &properties), "cudaMemPoolCreate");
        need(c, cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &all), "the pool");
        open_stream(c, c.copies);
        need(c, cudaMallocHost(&c.pinned, pinned_bytes), "cudaMallocHost");
        c.pool = pool;
        c.borrowed = true;
        *loop = pbw_cuda_loop{ properties.location.id, r.stream, options, cpu, c, loop_state(), {} };
    } catch (const failure &) {
        if (pool != NULL) {
            cudaMemPoolDestroy(pool);
        }
        pbw__release(&local.context.memory, loop, 1, sizeof *loop);
        loop = NULL;
    }
    *result = loop;
    return close_local(local);
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
                  loop->cpu, mesh, &loop->last, &loop->resources, points->rebuild != 0 };
    return run_request(r, &loop->options);
}

extern "C" void pbw_cuda_loop_free(pbw_cuda_loop *loop)
{
    if (loop != NULL) {
        pbw_memory memory;
        cudaFreeAsync(loop->last.id, loop->stream);
        pbw_cuda_free(&loop->last.mesh, loop->stream);
        pbw_cuda_cells_free(&loop->cells, loop->stream);
        cudaStreamSynchronize(loop->stream);
        destroy(loop->resources);
        cudaFreeHost(loop->resources.pinned);
        cudaMemPoolDestroy(loop->resources.pool);
        (void)cudaGetLastError();
        pbw_memory_start(&memory, &loop->options);
        memory.used = sizeof *loop;
        pbw__release(&memory, loop, 1, sizeof *loop);
    }
}

namespace {
/* ------------------------------------------------------------------------------------------------------
   >>dual         The calls for cells.
   In: a mesh and its points, on the current device.  Out: the arrays of its cells there.
   ------------------------------------------------------------------------------------------------------ */
/* Points as doubles. */
__global__ void widen_kernel(const float *from, size_t count, double *to)
{
    if (thread_number() < count) {
        to[thread_number()] = (double)from[thread_number()];
    }
}

/* Points that are no vertices have empty cells; so do those before the first cell. */
template <int DIM> __global__ void empty_kernel(const diagram d, const facet_lists lists)
{
    const size_t v = thread_number();
    const real nothing[4] = { 0.0, 0.0, 0.0, 0.0 };
    if (v < d.count && (!has_cell(d, v) || d.incident == NULL || d.incident[v] == none)) {
        set_cell<DIM>(d, (uint32_t)v, nothing);
        if (lists.first != NULL) {
            lists.first[v] = 0;
        }
    }
}

/* Counts facets: a closed star of n simplices has n / 2 + 2 links, by Euler; one with an end at most n + 2, and the
   box six walls.  Cells that are left and large stars get room for theirs; large stars are listed. */
__global__ void count_kernel(const diagram d, const stars s, const facet_lists lists, const queue left,
                             unsigned long long *room)
{
    const uint32_t v = (uint32_t)thread_number();
    if (v < d.count) {
        const uint32_t count = has_cell(d, v) ? s.first[v + 1] - s.first[v] : 0;
        const bool is_whole = lists.is_left[v] == 0;
        lists.first[v] = count > 0 ? count / 2 + 2 : 0;
        if (count > 0 && (!is_whole || count > facet_simplices)) {
            lists.begin[v] = atomicAdd(room, count + 8ull);
            if (is_whole) {
                left.vertex[atomicAdd(left.count, 1u)] = v;
            }
        }
    }
}

/* Lists all vertices, near ones together.  A thread a simplex: a warp adds all that it has at once. */
__global__ void vertices_kernel(const diagram d, const queue list)
{
    const size_t simplex = thread_number();
    uint32_t vertex[4], first = 0;
    int at[4], length = 0;
    for (size_t k = 0; k < 4; k++) {
        const uint32_t v = simplex < d.simplex_count ? d.simplices[4 * simplex + k] : none;
        vertex[k] = has_cell(d, v) && d.incident[v] == simplex ? v : none;
        at[k] = append<32>(vertex[k] != none, length);
    }
    if ((threadIdx.x & 31) == 0 && length > 0) {
        first = atomicAdd(list.count, (uint32_t)length);
    }
    first = __shfl_sync(all_lanes, first, 0);
    for (int k = 0; k < 4; k++) {
        if (vertex[k] != none) {
            list.vertex[first + (uint32_t)at[k]] = vertex[k];
        }
    }
}

/* The corners of all simplices as pairs to sort: (vertex, 4 simplex + corner). */
__global__ void pair_kernel(const uint32_t *simplices, size_t entries, uint32_t *vertex, uint32_t *entry)
{
    const size_t i = thread_number();
    if (i < entries) {
        vertex[i] = simplices[i];
        entry[i] = (uint32_t)i;
    }
}

int bits_of(size_t count)
{
    int bits = 1;
    while (bits < 32 && count >> bits != 0) {
        bits++;
    }
    return bits;
}

const double *widened(call &c, const void *from, bool is_float, size_t count)
{
    if (from == NULL || !is_float) {
        return (const double *)from;
    }
    double *const to = allocate<double>(c, count);
    launch(c, "points", widen_kernel, over(count, 256), (const float *)from, count, to);
    return to;
}

/* Lists of cells that are left, for rungs in turn; word: their counts, and of the first two rungs what is taken. */
struct left_cells {
    buffer<uint32_t> vertex[2], word;
    left_cells(call &c, size_t count) : vertex{ buffer<uint32_t>(c, count), buffer<uint32_t>(c, count) }, word(c, 8)
    {
        fill(c, word.at, 0, 8);
    }
    queue list(int i) { return { vertex[i & 1].at, word.at + i }; }
};

/* Facets: from the counts of all cells, where they begin, and their arrays. */
void make_lists(call &c, size_t count, facet_lists &lists)
{
    size_t all = 0;
    fill(c, lists.first + count, 0, 1);
    with_scratch(c, "scan", [&](void *scratch, size_t &bytes) {
        return cub::DeviceScan::ExclusiveSum(scratch, bytes, lists.first, lists.first, count + 1, c.stream);
    });
    all = read_back(c, lists.first + count, PBW_STAGE_WORK, 0.5);
    lists.neighbor = allocate<pbw_index>(c, all);
    lists.area = allocate<double>(c, all);
    lists.all = all;
}

const size_t most_room = (size_t)1 << 28;            /* bytes for all warps of a large rung */

template <typename INDEX>
void build_rung(call &c, const diagram &d, const facet_lists &lists, const star_rung &a, unsigned blocks)
{
    cell_room<INDEX> room;
    const size_t bytes = lay_out(size_of_room<INDEX>(a.size), NULL, room) * rung_shape<INDEX>::warps;
    const shape s = { blocks, 32 * rung_shape<INDEX>::warps, sizeof(INDEX) == 4 ? 0 : bytes };
    need(c, cudaFuncSetAttribute(star_kernel<INDEX>, cudaFuncAttributeMaxDynamicSharedMemorySize, (int)s.bytes),
         "shared memory");
    launch(c, "stars", star_kernel<INDEX>, s, d, lists, a);
}

/* The cells that are left, from their stars, in rungs: of rooms in shared memory, then, twice as large each time, in
   the memory of the device. */
void build_stars(call &c, const diagram &d, const facet_lists &lists, const stars &s, left_cells &left)
{
    const unsigned processors = (unsigned)processors_of(c, c.team->offers[c.card].device);
    star_rung a = { s, left.list(0), left.list(1), left.word.at + 6 };
    cell_room<uint32_t> room;
    int rung = 2;
    build_rung<uint8_t>(c, d, lists, a, processors * rung_shape<uint8_t>::blocks);
    a.todo = left.list(1);
    a.left = left.list(2);
    a.next = left.word.at + 7;
    build_rung<uint16_t>(c, d, lists, a, processors * rung_shape<uint16_t>::blocks);
    for (uint32_t n = 1024, count; (count = read_back(c, left.word.at + rung, PBW_STAGE_WORK, 0.9)) > 0; n *= 2) {
        require(c, n < 1u << 27, PBW_ERROR_BACKEND, "a cell is too large for the device");
        a.size = { n, n + 2, 4 * n, 8 * n, 16 * n, 2 * n, 4 * n };
        const size_t bytes = lay_out(a.size, NULL, room), fit = most_room / bytes;
        const size_t most = fit < processors * 8 ? fit : processors * 8;
        const unsigned warps = (unsigned)(most > count ? count : most > 1 ? most : 1);
        buffer<char> memory(c, warps * bytes);
        a.memory = memory.at;
        a.todo = left.list(rung);
        a.left = left.list(rung ^ 1);
        fill(c, a.left.count, 0, 1);
        fill(c, a.next, 0, 1);
        build_rung<uint32_t>(c, d, lists, a, warps);
        rung ^= 1;
    }
}

/* Those of all vertices. */
struct star_lists {
    buffer<uint32_t> first, entry;
    stars view() const { return { first.at, entry.at }; }
};

star_lists find_stars(call &c, const diagram &d)
{
    const size_t entries = 4 * (size_t)d.simplex_count;
    star_lists lists = { buffer<uint32_t>(c, (size_t)d.count + 1), buffer<uint32_t>(c) };
    sortable<uint32_t> vertices(c, entries), numbers(c, entries);
    launch(c, "pairs", pair_kernel, over(entries, 256), d.simplices, entries, vertices.array.at, numbers.array.at);
    sort_pairs(c, vertices, numbers, entries, { 0, bits_of(c.count) });
    launch(c, "stars", find_first_kernel, over(entries + 1, 256), vertices.array.at, entries, lists.first.at,
           d.count);
    lists.entry = std::move(numbers.array);
    record_mark(c, 1);
    return lists;
}

/* Volumes and centroids in space but for those that are left, which are listed.  part: for facets, else NULL. */
void sum_cells(call &c, const diagram &d, const stars &s, unsigned char *is_left, edge_parts *part,
               const queue &left)
{
    const size_t simplices = d.simplex_count;
    buffer<sums> sum(c, 4 * simplices);
    contributions out = { {}, part, is_left };
    for (size_t i = 0; i < 4; i++) {
        out.sum[i] = sum.at + i * simplices;
    }
    fill(c, is_left, 0, c.count);
    launch(c, "contributions",
           part != NULL ? d.weights != NULL ? contribute_kernel<true, true> : contribute_kernel<false, true>
                        : d.weights != NULL ? contribute_kernel<true, false> : contribute_kernel<false, false>,
           over(simplices, contribute_block), d, out);
    record_mark(c, 2);
    launch(c, "sums", sum_kernel, over(4 * (size_t)(d.count - d.start), 256), d, out, s, left);
}

/* Volumes and centroids alone, in space. */
void space_cells(call &c, const diagram &d)
{
    const star_lists at = find_stars(c, d);
    buffer<unsigned char> is_left(c, c.count);
    left_cells left(c, d.count);
    sum_cells(c, d, at.view(), is_left.at, NULL, left.list(0));
    record_mark(c, 3);
    build_stars(c, d, facet_lists(), at.view(), left);
}

/* Facets, too.  Those of cells that are left are made with their cells, then copied to their places among all. */
void space_facets(call &c, const diagram &d, facet_lists &lists)
{
    const star_lists at = find_stars(c, d);
    buffer<unsigned char> is_left(c, c.count);
    buffer<edge_parts> part(c, d.simplex_count);
    buffer<size_t> begin(c, (size_t)d.count + 1);
    buffer<uint32_t> vertex(c, (size_t)d.count + 1);
    const queue list = { vertex.at + 1, vertex.at };
    unsigned long long *const room = (unsigned long long *)begin.at + d.count;
    left_cells left(c, d.count);
    sum_cells(c, d, at.view(), is_left.at, part.at, left.list(0));
    facet_lists made = { lists.first, NULL, NULL, 0, begin.at, part.at, is_left.at };
    fill(c, room, 0, 1);
    launch(c, "counts", count_kernel, over(d.count, 256), d, at.view(), made, left.list(0), room);
    const size_t all = read_back(c, begin.at + d.count, PBW_STAGE_WORK, 0.5);
    buffer<uint32_t> neighbor(c, all);
    buffer<double> area(c, all);
    made.neighbor = neighbor.at;
    made.area = area.at;
    record_mark(c, 3);
    build_stars(c, d, made, at.view(), left);
    make_lists(c, d.count, lists);
    fill(c, vertex.at, 0, 1);
    launch(c, "vertices", vertices_kernel, over(d.simplex_count, 256), d, list);
    launch(c, "facets", facet_kernel, over((size_t)d.count * facet_lanes, 128), d, made, lists, at.view(), list);
}

/* All cells of the plane; with facets, their counts or the lists. */
void plane_pass(call &c, const diagram &d, const facet_lists &lists)
{
    left_cells left(c, d.count);
    int rung = 0;
    launch(c, "cells", plane_kernel, over(d.simplex_count, 128), d, lists, left.list(0));
    for (uint32_t n = 32, count; (count = read_back(c, left.word.at + rung, PBW_STAGE_WORK, 0.5)) > 0; n *= 2) {
        require(c, n < 1u << 28, PBW_ERROR_BACKEND, "a cell is too large for the device");
        const size_t fit = most_room / polygon_bytes(n), threads = count < fit ? count : fit > 1 ? fit : 1;
        const shape s = over(threads, 64);
        buffer<char> memory(c, (size_t)s.blocks * s.threads * polygon_bytes(n));
        fill(c, left.word.at + (rung ^ 1), 0, 1);
        launch(c, "cut cells", polygon_kernel, s, d, lists, left.list(rung), left.list(rung ^ 1), memory.at, n);
        rung ^= 1;
    }
}

void plane_cells(call &c, const diagram &d, facet_lists &lists)
{
    launch(c, "empty cells", empty_kernel<2>, over(d.count, 256), d, lists);
    plane_pass(c, d, lists);
    record_mark(c, 1);
    if (lists.first != NULL) {
        make_lists(c, d.count, lists);
        plane_pass(c, d, lists);
    }
    record_mark(c, 2);
    record_mark(c, 3);
}

const char too_uneven[] = "few or uneven points need too many copies: pbw_cells_periodic makes their cells";

/* A box that repeats along some axes; there points are in units, from 0 to the size, and so are their copies. */
struct period {
    int dim;
    unsigned axes;
    size_t count, total;                             /* points; with copies */
    double low[3], size[3], unit[3], margin[3];      /* low: 0 along others; margin: of the padded box */
    double from[3], to[3], extent[3];                /* as in the diagram; of the points and the box */
    double heaviest, lightest;
    uint32_t *source;                                /* of each copy */
    bool *missing;                                   /* to be set if copies are missing */
};

/* What a call for cells is given, and gives. */
struct cells_request {
    const pbw_cuda_mesh *mesh;
    const pbw_cuda_points *points;
    const double *box;
    unsigned what;
    pbw_triangulator *cpu;
    pbw_cuda_cells *cells;
    const period *repeats;                           /* NULL, or the points are those and their copies */
    size_t from, to;                                 /* cells of these points alone; to 0: of all */
};

bool is_sound(const cells_request &q)
{
    const pbw_cuda_mesh *m = q.mesh;
    const pbw_cuda_points *p = q.points;
    bool sound = q.cells != NULL && m != NULL && p != NULL && (p->dim == 2 || p->dim == 3)
              && (q.what & ~PBW_CUDA_FACETS) == 0 && (p->points != NULL || p->count == 0) && p->count < PBW_NONE - 4;
    sound = sound && (m->simplex_count == 0
                      || (m->dim == p->dim && m->point_count == p->count && m->simplex_count < PBW_NONE / 4
                          && m->simplices != NULL && m->neighbors != NULL && m->incident != NULL));
    for (int k = 0; sound && q.box != NULL && k < p->dim; k++) {
        const double low = q.box[k], high = q.box[p->dim + k];
        sound = low < high && high - low < HUGE_VAL;
    }
    return sound;
}

diagram diagram_of(const cells_request &q)
{
    const int dim = q.points->dim;
    const period *const p = q.repeats;
    diagram d = {};
    d.bounded = q.box != NULL || p != NULL;
    d.start = (uint32_t)q.from;
    d.count = (uint32_t)(p != NULL ? p->count : q.to > 0 ? q.to : q.points->count);
    d.padded.axes = p != NULL ? p->axes : 0;
    for (int k = 0; k < 3; k++) {
        const bool is_there = d.bounded && k < dim, is_wall = is_there && (d.padded.axes >> k & 1) == 0;
        d.from[k] = is_there ? p != NULL ? p->from[k] : q.box[k] : -HUGE_VAL;
        d.to[k] = is_there ? p != NULL ? p->to[k] : q.box[dim + k] : HUGE_VAL;
        d.low[k] = is_wall ? d.from[k] : -HUGE_VAL;
        d.high[k] = is_wall ? d.to[k] : HUGE_VAL;
        d.extent[k] = d.to[k] - d.from[k];
        d.slack[k] = is_wall ? 1e-14 * (fabs(d.low[k]) + fabs(d.high[k])) : 0.0;
    }
    return d;
}

/* Appends to host points, which span no simplex, the corners of one that is far around them and the box, of the least
   weight: as >>flat of pbw_cells.h. */
void add_apexes(const diagram &d, int dim, double *x, double *w)
{
    double low[3], high[3], far_out = 0.0;
    for (int k = 0; k < dim; k++) {
        low[k] = d.low[k];
        high[k] = d.high[k];
        for (size_t i = 0; i < d.count; i++) {
            low[k] = std::min(low[k], x[i * (size_t)dim + (size_t)k]);
            high[k] = std::max(high[k], x[i * (size_t)dim + (size_t)k]);
        }
        far_out += 8 * (high[k] - low[k]);
    }
    for (int i = 0; i <= dim; i++) {
        for (int k = 0; k < dim; k++) {
            const double away = i == dim ? -far_out : i == k ? far_out : 0;
            x[(d.count + (size_t)i) * (size_t)dim + (size_t)k] = low[k] + away;
        }
        if (w != NULL) {
            w[d.count + (size_t)i] = *std::min_element(w, w + d.count);
        }
    }
}

/* Makes the diagram of points that span no simplex, by the CPU, that of them and of apexes around them.  The mesh is
   the call's until it ends. */
void span(call &c, const cells_request &q, diagram &d, pbw_options options)
{
    pbw_memory &memory = ((pbw__dispatch *)c.job->context)->context->memory;
    const size_t dim = (size_t)q.points->dim, total = d.count + dim + 1, numbers = total * (dim + 1);
    input in = { d.points, d.weights, d.count, (int)dim, 0 };
    double *const x = (double *)pbw__allocate(&memory, numbers, sizeof(double)), *w = NULL;
    pbw_cuda_mesh made = {};
    pbw_mesh host = {};
    require(c, x != NULL, PBW_ERROR_MEMORY, no_host_memory);
    options.backend = NULL;
    options.trace = NULL;
    options.flags = 0;
    options.stride = options.weight_stride = 0;
    options.memory_limit -= options.memory_limit > 0 ? memory.used - (memory.used == memory.limit) : 0;
    try {
        fetch_points(c, in, x, d.count * dim);
        if (d.weights != NULL) {
            w = x + total * dim;
            memmove(w, x + d.count * dim, d.count * sizeof *w);
        }
        add_apexes(d, (int)dim, x, w);
        const pbw_status status = q.cpu((int)dim, x, w, total, &options, &host);
        require(c, status == PBW_OK, status, pbw_status_string(status));
        in.count = total;
        c.mesh = &made;
        send_mesh(c, host, in);
        double *const there = allocate<double>(c, numbers);
        need(c, cudaMemcpyAsync(there, x, numbers * sizeof *x, cudaMemcpyHostToDevice, c.stream), "copying points");
        d.points = there;
        d.weights = w != NULL ? there + total * dim : NULL;
    } catch (const failure &) {
    }
    c.mesh = NULL;
    wait_for_stream(c, c.stream, PBW_STAGE_WORK, 0.1);       /* the host arrays are freed next */
    pbw_free(&host);
    pbw__release(&memory, x, numbers, sizeof(double));
    throw_if_failed(c);
    c.count = total;
    d.simplices = made.simplices;
    d.neighbors = made.neighbors;
    d.incident = made.incident;
    d.simplex_count = (uint32_t)made.simplex_count;
}

/* Clears *good if the padded box does not hold the balls of simplices at cells that are not cut.  Where no walls are,
   these must be closed. */
template <int DIM> __global__ void certify_kernel(const diagram d)
{
    const size_t simplex = thread_number();
    if (simplex >= d.simplex_count) {
        return;
    }
    const uint32_t *corner = d.simplices + simplex * (DIM + 1), *next = d.neighbors + simplex * (DIM + 1);
    const double *a = d.points + (size_t)corner[0] * DIM;
    const unsigned char *is_cut = d.padded.is_cut;
    real centre[3];
    bool read = false, fits = true;
    for (int i = 0; i <= DIM; i++) {
        read = read || (corner[i] < d.count && (is_cut == NULL || is_cut[corner[i]] == 0));
        fits = fits && (is_cut != NULL || next[i] != none);
    }
    if (read) {
        fits = fits && (centre_of<DIM>(d, (uint32_t)simplex, centre) & good_centre) != 0;
        real square = d.weights != NULL ? real(d.padded.heaviest) - d.weights[corner[0]] : real(0.0);
        for (int k = 0; k < DIM; k++) {
            square += centre[k] * centre[k];
            centre[k] += a[k];
        }
        hold_ball<DIM>(d.padded, centre, square);
        if (!fits) {
            *d.padded.good = 0;
        }
    }
}

/* The padded box of a diagram; slack: more than that of the CPU, which then adds no copies. */
void pad(call &c, diagram &d, const period &p, uint32_t *good, unsigned char *is_cut)
{
    double slack = sqrt(p.heaviest - p.lightest);
    for (int k = 0; k < p.dim; k++) {
        d.padded.size[k] = p.size[k];
        d.padded.margin[k] = p.margin[k];
        slack += p.extent[k];
    }
    d.padded.heaviest = p.heaviest;
    d.padded.slack = 1e-11 * slack;
    d.padded.good = good;
    d.padded.is_cut = is_cut;
    fill(c, good, d.simplex_count > 0 ? 1 : 0, 1);
    if (is_cut != NULL) {
        fill(c, is_cut, 0, p.count);
    }
}

void certify(call &c, const diagram &d, const period &p)
{
    if (d.simplex_count > 0) {
        launch(c, "copies", p.dim == 3 ? certify_kernel<3> : certify_kernel<2>, over(d.simplex_count, 128), d);
    }
    *p.missing = read_back(c, d.padded.good, PBW_STAGE_WORK, 0.1) == 0;
    require(c, !*p.missing, PBW_ERROR_BACKEND, too_uneven);
}

/* Replaces copies by their points and shifts. */
__global__ void unwrap_facets_kernel(const diagram d, const period p, size_t facets, uint32_t *neighbor,
                                     signed char *shift)
{
    const size_t i = thread_number(), dim = (size_t)p.dim;
    if (i < facets) {
        const uint32_t copy = neighbor[i];
        const bool is_copy = copy >= p.count && copy < p.total;              /* else a point, or a wall */
        const uint32_t point = is_copy ? p.source[copy - p.count] : copy;
        neighbor[i] = point;
        for (size_t k = 0; k < dim; k++) {
            real by = 0.0;
            if (is_copy && (p.axes >> k & 1) != 0) {
                by = (real(d.points[(size_t)copy * dim + k]) - d.points[(size_t)point * dim + k]) / p.size[k];
            }
            shift[i * dim + k] = (signed char)by.value;
        }
    }
}

/* Moves all back to the caller's box. */
__global__ void unwrap_kernel(const diagram d, const period p, double *sites)
{
    const size_t i = thread_number(), dim = (size_t)p.dim;
    if (i < p.count * dim) {
        d.centroids[i] = (real(d.centroids[i]) + p.low[i % dim]).value;
        sites[i] = (real(d.points[i]) + p.low[i % dim]).value;
    }
}

void unwrap(call &c, const diagram &d, const period &p, pbw_cuda_cells &cells)
{
    const size_t dim = (size_t)p.dim;
    cells.sites = allocate<double>(c, p.count * dim);
    launch(c, "sites", unwrap_kernel, over(p.count * dim, 256), d, p, cells.sites);
    if (cells.neighbors != NULL) {
        cells.shifts = allocate<signed char>(c, cells.facet_count * dim);
        launch(c, "shifts", unwrap_facets_kernel, over(cells.facet_count, 256), d, p, cells.facet_count,
               cells.neighbors, cells.shifts);
    }
}

/* Makes the cells; returns PBW_OK or PBW_DEGENERATE. */
pbw_status make_cells(call &c, const cells_request &q, const pbw_options &options)
{
    const pbw_cuda_points &p = *q.points;
    const size_t dim = (size_t)p.dim;
    pbw_cuda_cells &cells = *q.cells;
    facet_lists lists = {};
    diagram d = diagram_of(q);
    const bool spans = q.mesh->simplex_count > 0, has_walls = q.repeats != NULL && q.repeats->axes + 1 != 1u << dim;
    buffer<uint32_t> good(c);
    buffer<unsigned char> is_cut(c);
    record_mark(c, 0);
    c.count = p.count;
    cells.dim = p.dim;
    cells.cell_count = d.count;
    cells.volumes = d.volumes = allocate<double>(c, d.count);
    cells.centroids = d.centroids = allocate<double>(c, d.count * dim);
    if ((q.what & PBW_CUDA_FACETS) != 0) {
        cells.first = lists.first = allocate<size_t>(c, (size_t)d.count + 1);
    }
    d.points = widened(c, p.points, p.is_float != 0, p.count * dim);
    d.weights = widened(c, p.weights, p.is_float != 0, p.count);
    d.simplices = q.mesh->simplices;
    d.neighbors = q.mesh->neighbors;
    d.incident = spans ? q.mesh->incident : NULL;
    d.simplex_count = (uint32_t)q.mesh->simplex_count;
    if (q.repeats != NULL) {
        good.make(1);
        if (has_walls) {
            is_cut.make(d.count);
        }
        pad(c, d, *q.repeats, good.at, is_cut.at);
    }
    if (q.repeats != NULL && !(spans && has_walls)) {
        certify(c, d, *q.repeats);                   /* before the cells, which can wait for copies */
    } else if (q.repeats == NULL && !spans && d.bounded && p.count > 0) {
        decline_unless(c, q.cpu != NULL, "points that span no simplex need the CPU");
        span(c, q, d, options);
    }
    if (d.simplex_count == 0) {
        launch(c, "empty cells", dim == 3 ? empty_kernel<3> : empty_kernel<2>, over(p.count, 256), d, lists);
        if (lists.first != NULL) {
            make_lists(c, p.count, lists);
        }
    } else if (dim == 2) {
        plane_cells(c, d, lists);
    } else if (lists.first != NULL) {
        space_facets(c, d, lists);
    } else {
        space_cells(c, d);
    }
    cells.facet_count = lists.all;
    cells.neighbors = lists.neighbor;
    cells.areas = lists.area;
    if (has_walls) {                                 /* now that it is known which cells they cut */
        certify(c, d, *q.repeats);
    }
    if (q.repeats != NULL) {
        unwrap(c, d, *q.repeats, cells);
    }
    record_mark(c, 4);
    wait(c, PBW_STAGE_WORK, 1.0);
    for (int i = 0; i < 5 && d.simplex_count > 0; i++) {
        need(c, cudaEventElapsedTime(&cells.milliseconds[i], c.mark[i < 4 ? i : 0], c.mark[i < 4 ? i + 1 : 4]),
             "cudaEventElapsedTime");
    }
    return d.simplex_count > 0 ? PBW_OK : PBW_DEGENERATE;
}

/* The arrays of cells. */
struct cell_arrays {
    void *at[7];
    size_t bytes[7];
};

cell_arrays arrays_of(const pbw_cuda_cells &cells)
{
    const size_t count = cells.cell_count, facets = cells.facet_count;
    const size_t dim = (size_t)cells.dim;
    return { { cells.volumes, cells.centroids, cells.first, cells.areas, cells.neighbors, cells.sites, cells.shifts },
             { count * sizeof(double), count * dim * sizeof(double), (count + 1) * sizeof(size_t),
               facets * sizeof(double), facets * sizeof(pbw_index), count * dim * sizeof(double), facets * dim } };
}

void release_cells(call &c, const pbw_cuda_cells &cells)
{
    for (const void *array : arrays_of(cells).at) {
        release(c, array, true);
    }
}

pbw_status run_cells(const cells_request &q, const pbw_options *given_options, cudaStream_t stream,
                     const call_resources *resources)
{
    request r = {};
    local_call local{};
    pbw_status status = PBW_OK;
    if (q.cells != NULL) {
        memset(q.cells, 0, sizeof *q.cells);
    }
    if (!is_sound(q) || !take_options(r.options, given_options)) {
        return PBW_ERROR_ARGUMENT;
    }
    r.in.dim = q.points->dim;
    r.stream = stream;
    r.cpu = q.cpu;
    r.resources = resources;
    try {
        open_local(local, r);
        status = make_cells(local.c, q, r.options);
        release_cells(local.c, *q.cells);
    } catch (const failure &) {
        memset(q.cells, 0, sizeof *q.cells);
    }
    const pbw_status failed = close_local(local);
    if (failed != PBW_OK) {
        pbw_cuda_cells_free(q.cells, stream);
    }
    return failed != PBW_OK ? failed : status;
}

} /* namespace */

extern "C" pbw_status pbw_cuda_cells_of(const pbw_cuda_mesh *mesh, const pbw_cuda_points *points, const double *box,
                                        unsigned what, const pbw_options *options, void *stream,
                                        pbw_triangulator *cpu, pbw_cuda_cells *cells)
{
    return run_cells({ mesh, points, box, what, cpu, cells, NULL }, options, (cudaStream_t)stream, NULL);
}

namespace {
/* ------------------------------------------------------------------------------------------------------
   >>transfer     Cells of points in the memory of the host; the end of cells; cells of a loop.
   In: points in the memory of the host.  Out: the arrays of their cells there.
   ------------------------------------------------------------------------------------------------------ */
/* The memory of the host that holds the arrays of cells, which follow it. */
struct alignas(16) host_cells {
    pbw_memory memory;
    size_t bytes;
};

/* What a card has of a call: points, their mesh, and the cells of its points, which are those from q.from to
   q.to - 1. */
struct card_cells {
    int device;
    cudaStream_t stream;
    pbw_cuda_points points;
    pbw_cuda_mesh mesh;
    pbw_cuda_cells made;
    cells_request q;
    pbw_options options;
    size_t facets_before;                            /* those of the cards before */
    pbw_status status;
};

/* Calls f(card) for each card, side by side, where that is current. */
template <typename F> void on_cards(card_cells *cards, int count, F f)
{
    std::thread helper[most_cards];
    auto call = [&](card_cells &card) {
        card.status = cudaSetDevice(card.device) == cudaSuccess ? f(card) : PBW_ERROR_BACKEND;
    };
    for (int i = 1; i < count; i++) {
        try {
            helper[i] = std::thread(call, std::ref(cards[i]));
        } catch (...) {
            cards[i].status = PBW_ERROR_THREAD;
        }
    }
    call(cards[0]);
    for (int i = 1; i < count; i++) {
        if (helper[i].joinable()) {
            helper[i].join();
        }
    }
}

pbw_status worst_of(const card_cells *cards, int count)
{
    pbw_status status = cards[0].status;
    for (int i = 1; i < count && (status == PBW_OK || status == PBW_DEGENERATE); i++) {
        status = cards[i].status;
    }
    return status;
}

template <typename V> bool copy_to(V *&to, const V *from, size_t count, cudaStream_t stream)
{
    return cudaMallocAsync((void **)&to, count * sizeof(V) + 1, stream) == cudaSuccess
        && cudaMemcpyAsync(to, from, count * sizeof(V), cudaMemcpyDefault, stream) == cudaSuccess;
}

/* Copies between a card and the host, or another card; all is there when it returns. */
cudaError_t copy_now(const card_cells &card, const host_copy *copies, int count, bool to_host)
{
    const int threads = pbw__thread_count(card.options.threads, card.points.count);
    staged_copies s = { copies, count, card.device, to_host };
    cudaError_t error = cudaStreamSynchronize(card.stream);
    if (error == cudaSuccess && !is_pinned(to_host ? copies->to : copies->from)
        && copy_staged(s, threads, [] { return true; })) {
        return (cudaError_t)s.error.load();
    }
    for (int i = 0; i < count && error == cudaSuccess; i++) {
        error = cudaMemcpyAsync(copies[i].to, copies[i].from, copies[i].bytes, cudaMemcpyDefault, card.stream);
    }
    const cudaError_t arrived = cudaStreamSynchronize(card.stream);  /* copies may be under way after an error */
    return error != cudaSuccess ? error : arrived;
}

/* Copies points to a card. */
bool send_points(card_cells &card, const pbw_cuda_points &from)
{
    const void *const source[2] = { from.points, from.weights };
    const int count = from.weights != NULL ? 2 : 1;
    void *there[2] = {};
    host_copy copies[2];
    cudaError_t error = cudaSuccess;
    for (int i = 0; i < count && error == cudaSuccess; i++) {
        const size_t bytes = from.count * sizeof(double) * (i == 0 ? (size_t)from.dim : 1);
        error = cudaMallocAsync(&there[i], bytes + 1, card.stream);
        copies[i] = { (char *)there[i], (const char *)source[i], bytes, NULL };
    }
    card.points = { from.dim, 0, there[0], there[1], from.count, 0 };
    return error == cudaSuccess && copy_now(card, copies, count, false) == cudaSuccess;
}

/* Copies points and their mesh from another card, where they are complete. */
bool share_mesh(card_cells &card, const card_cells &from)
{
    const size_t corners = from.mesh.simplex_count * (size_t)(from.mesh.dim + 1);
    const pbw_cuda_mesh &m = from.mesh;
    cudaMemPool_t pool;
    const cudaMemAccessDesc access = { { cudaMemLocationTypeDevice, card.device }, cudaMemAccessFlagsProtReadWrite };
    if (card.device != from.device && cudaDeviceGetMemPool(&pool, from.device) == cudaSuccess) {
        (void)cudaMemPoolSetAccess(pool, &access, 1);                /* or copies go by way of the host */
        (void)cudaGetLastError();
    }
    card.mesh = m;
    card.mesh.simplices = card.mesh.neighbors = card.mesh.incident = card.mesh.canonical = NULL;
    return send_points(card, from.points) && copy_to(card.mesh.simplices, m.simplices, corners, card.stream)
        && copy_to(card.mesh.neighbors, m.neighbors, corners, card.stream)
        && copy_to(card.mesh.incident, m.incident, m.point_count, card.stream);
}

/* The arrays of cells in the memory of the host, which are still to be filled.  Returns a status. */
pbw_status lay_out_cells(const card_cells *cards, int count, const pbw_options &options, pbw_cuda_cells *cells)
{
    const card_cells &last = cards[count - 1];
    pbw_cuda_cells all = last.made;
    size_t bytes = sizeof(host_cells);
    pbw_memory memory;
    void *to[7] = {};
    pbw_memory_start(&memory, &options);
    all.facet_count += last.facets_before;
    const cell_arrays arrays = arrays_of(all);
    for (int i = 0; i < 7; i++) {
        bytes += arrays.at[i] != NULL ? arrays.bytes[i] : 0;
    }
    host_cells *const block = (host_cells *)pbw__allocate(&memory, bytes, 1);
    if (block == NULL) {
        return PBW_ERROR_MEMORY;
    }
    char *next = (char *)(block + 1);
    for (int i = 0; i < 7; i++) {
        if (arrays.at[i] != NULL) {
            to[i] = next;
            next += arrays.bytes[i];
        }
    }
    *block = host_cells{ memory, bytes };
    *cells = all;
    cells->volumes = (double *)to[0];
    cells->centroids = (double *)to[1];
    cells->first = (size_t *)to[2];
    cells->areas = (double *)to[3];
    cells->neighbors = (pbw_index *)to[4];
    cells->sites = (double *)to[5];
    cells->shifts = (signed char *)to[6];
    cells->memory = block;
    return PBW_OK;
}

/* Copies what a card has made to its places. */
pbw_status fetch_cells(const card_cells &card, const pbw_cuda_cells &cells)
{
    const size_t from = card.q.from, count = card.made.cell_count - from, dim = (size_t)cells.dim;
    const size_t firsts = count + (card.made.cell_count == cells.cell_count);        /* the last card has the end */
    const size_t before = card.facets_before, facets = card.made.facet_count;
    const pbw_cuda_cells &made = card.made;
    host_copy copies[7] = {};
    int some = 0;
    auto copy = [&](void *to, const void *source, size_t at, size_t skipped, size_t bytes) {
        if (source != NULL) {
            copies[some++] = { (char *)to + at, (const char *)source + skipped, bytes, NULL };
        }
    };
    const size_t place = from * sizeof(double);
    copy(cells.volumes, made.volumes, place, place, count * sizeof(double));
    copy(cells.centroids, made.centroids, place * dim, place * dim, count * dim * sizeof(double));
    copy(cells.first, made.first, place, place, firsts * sizeof(size_t));
    copy(cells.areas, made.areas, before * sizeof(double), 0, facets * sizeof(double));
    copy(cells.neighbors, made.neighbors, before * sizeof(pbw_index), 0, facets * sizeof(pbw_index));
    copy(cells.sites, made.sites, 0, 0, count * dim * sizeof(double));
    copy(cells.shifts, made.shifts, 0, 0, facets * dim);
    const bool good = copy_now(card, copies, some, true) == cudaSuccess;
    for (size_t i = from; good && before > 0 && i < from + firsts; i++) {
        cells.first[i] += before;
    }
    return good ? PBW_OK : PBW_ERROR_BACKEND;
}

/* Copies points to the first card and makes their mesh there; of a box that repeats along axes the cells, too. */
pbw_status start_cells(card_cells &card, const pbw_cuda_points &host, unsigned axes)
{
    const cells_request &q = card.q;
    if (cudaStreamCreateWithFlags(&card.stream, cudaStreamNonBlocking) != cudaSuccess || !send_points(card, host)) {
        return PBW_ERROR_BACKEND;
    }
    return axes != 0 ? pbw_cuda_cells_periodic(&card.points, q.box, axes, q.what, &card.options, card.stream, q.cpu,
                                               &card.made)
         : pbw_cuda_triangulate(host.dim, 0, card.points.points, card.points.weights, host.count, &card.options,
                                card.stream, q.cpu, &card.mesh);
}

/* Makes the cells of a card's points; others than the first get points and mesh from that. */
pbw_status continue_cells(card_cells &card, const card_cells &first)
{
    cells_request q = card.q;
    pbw_options options = card.options;
    if (&card != &first
        && (cudaStreamCreateWithFlags(&card.stream, cudaStreamNonBlocking) != cudaSuccess
            || !share_mesh(card, first))) {
        return PBW_ERROR_BACKEND;
    }
    q.mesh = &card.mesh;
    q.points = &card.points;
    q.cells = &card.made;
    options.flags = 0;
    return run_cells(q, &options, card.stream, NULL);
}

/* Frees all that a card has. */
pbw_status end_cells(card_cells &card)
{
    pbw_cuda_free(&card.mesh, card.stream);
    pbw_cuda_cells_free(&card.made, card.stream);
    for (const void *array : { card.points.points, card.points.weights }) {
        if (array != NULL) {
            cudaFreeAsync((void *)(uintptr_t)array, card.stream);
        }
    }
    if (card.stream != NULL) {
        cudaStreamSynchronize(card.stream);
        cudaStreamDestroy(card.stream);
    }
    return card.status;
}

/* Makes the mesh on the first card, and an equal share of the cells on each.  Returns a status. */
pbw_status make_host_cells(card_cells *cards, int count, const pbw_cuda_points &host, unsigned axes,
                           pbw_cuda_cells *cells)
{
    size_t facets = 0;
    on_cards(cards, 1, [&](card_cells &card) { return start_cells(card, host, axes); });
    pbw_status status = cards[0].status;
    if (axes == 0 && (status == PBW_OK || status == PBW_DEGENERATE)) {
        const size_t most = cards[0].mesh.simplex_count > 0 ? host.count : 1;    /* a share has a point or more */
        count = (size_t)count < most ? count : (int)most;
        const size_t step = host.count / (size_t)count;
        for (int i = 0; i < count && count > 1; i++) {
            cards[i].q.from = step * (size_t)i;
            cards[i].q.to = i + 1 < count ? step * (size_t)(i + 1) : host.count;
        }
        on_cards(cards, count, [&](card_cells &card) { return continue_cells(card, cards[0]); });
        status = worst_of(cards, count);
    } else {
        count = 1;
    }
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        return status;
    }
    for (int i = 0; i < count; i++) {
        cards[i].facets_before = facets;
        facets += cards[i].made.facet_count;
    }
    const pbw_status laid_out = lay_out_cells(cards, count, cards[0].options, cells);
    if (laid_out != PBW_OK) {
        return laid_out;
    }
    on_cards(cards, count, [&](card_cells &card) { return fetch_cells(card, *cells); });
    const pbw_status fetched = worst_of(cards, count);
    if (fetched != PBW_OK) {
        pbw_cuda_cells_free(cells, NULL);
    }
    return fetched != PBW_OK ? fetched : status;
}

void say(const pbw_options &options, const char *what, const char *why)
{
    if (options.message != NULL && options.message_size > 0) {
        snprintf(options.message, options.message_size, "%s%s", what, why);
    }
}

} /* namespace */

extern "C" pbw_status pbw_cuda_cells_of_host(int dim, const double *points, const double *weights, size_t count,
                                             const double *box, unsigned axes, unsigned what,
                                             const pbw_options *given_options, pbw_triangulator *cpu,
                                             pbw_cuda_cells *cells)
{
    const pbw_cuda_points host = { dim, 0, points, weights, count, 0 };
    const pbw_cuda_mesh no_mesh = {};
    const cells_request q = { &no_mesh, &host, box, what, cpu, cells };
    device_list devices = { {}, 1, {}, NULL };
    card_cells cards[most_cards] = {};
    pbw_options options;
    int before = 0;
    if (cells != NULL) {
        memset(cells, 0, sizeof *cells);
    }
    if (cells == NULL || !is_sound(q) || !take_options(options, given_options)
        || (options.backend != NULL && options.backend->triangulate != triangulate)) {
        return PBW_ERROR_ARGUMENT;
    }
    say(options, "", "");
    pbw_status status = PBW_ERROR_BACKEND;
    const cudaError_t found = cudaGetDevice(&before);
    if (found == cudaSuccess) {
        devices.device[0] = before;
        if (options.backend != NULL) {
            devices = *(const device_list *)options.backend->user;
        }
        options.backend = NULL;
        for (int i = 0; i < devices.count; i++) {
            cards[i].device = devices.device[i];
            cards[i].q = q;
            cards[i].options = options;
            if (i > 0) {                             /* these are called by the caller's thread alone */
                cards[i].options.progress = NULL;
                cards[i].options.message = NULL;
                cards[i].q.cpu = NULL;
            }
        }
        status = make_host_cells(cards, devices.count, host, axes, cells);
        on_cards(cards, devices.count, end_cells);
        cudaSetDevice(before);
    }
    const cudaError_t error = cudaGetLastError();
    if (status == PBW_ERROR_BACKEND && error != cudaSuccess
        && (options.message == NULL || options.message_size == 0 || options.message[0] == 0)) {
        say(options, found == cudaSuccess ? "" : "no usable device: ", cudaGetErrorString(error));
    }
    return status;
}

extern "C" void pbw_cuda_cells_free(pbw_cuda_cells *cells, void *stream)
{
    if (cells == NULL) {
        return;
    }
    if (cells->memory != NULL) {
        host_cells *const block = (host_cells *)cells->memory;
        pbw_memory memory = block->memory;
        pbw__release(&memory, block, block->bytes, 1);
    } else {
        for (void *array : arrays_of(*cells).at) {
            if (array != NULL) {
                cudaFreeAsync(array, (cudaStream_t)stream);
            }
        }
    }
    memset(cells, 0, sizeof *cells);
}

extern "C" pbw_status pbw_cuda_loop_cells(pbw_cuda_loop *loop, const pbw_cuda_points *points, const double *box,
                                          unsigned what, pbw_cuda_cells *cells)
{
    int device = -1;
    pbw_cuda_cells made = {};
    if (cells != NULL) {
        memset(cells, 0, sizeof *cells);
    }
    if (loop == NULL || cells == NULL || cudaGetDevice(&device) != cudaSuccess || device != loop->device) {
        (void)cudaGetLastError();
        return PBW_ERROR_ARGUMENT;
    }
    const cells_request q = { &loop->last.mesh, points, box, what, loop->cpu, &made, NULL };
    const pbw_status status = run_cells(q, &loop->options, loop->stream, &loop->resources);
    pbw_cuda_cells_free(&loop->cells, loop->stream);
    *cells = loop->cells = made;
    return status;
}

namespace {
/* ------------------------------------------------------------------------------------------------------
   >>periods      Cells of points in a periodic box.
   In: points on the current device.  Out: the arrays of their cells there.
   Holds: units, copies and their order are those of the first round of pbw_cells_periodic.  If that is its last, the
   bytes are the same; else more copies are made here, twice as far.
   ------------------------------------------------------------------------------------------------------ */
/* As >>units of pbw_cells.h, but for margins: of so many spacings.  Returns false for a box that it refuses. */
bool set_sizes(const double *box, int dim, unsigned axes, size_t count, double spacings, period &p)
{
    double longest = 0, volume = 1;
    p.dim = dim;
    p.axes = axes;
    p.count = count;
    for (int k = 0; k < dim; k++) {
        p.low[k] = (axes >> k & 1) != 0 ? box[k] : 0.0;
        p.size[k] = box[dim + k] - box[k];
        if (!(p.size[k] > 1e-150) || !(p.size[k] < 1e150)) {
            return false;
        }
        longest = p.size[k] > longest ? p.size[k] : longest;
        volume *= p.size[k];
    }
    const double spacing = pow(volume / (double)(count > 0 ? count : 1), 1.0 / (double)dim);
    for (int k = 0; k < dim; k++) {
        double reach = longest / p.size[k];
        int exponent;
        (void)frexp(p.size[k], &exponent);
        for (exponent -= 51; reach > 1; reach /= 2) {
            exponent++;
        }
        p.unit[k] = ldexp(1, exponent + 3);
        p.size[k] = floor(p.size[k] / p.unit[k] + 0.5) * p.unit[k];
        p.margin[k] = spacings * spacing < p.size[k] ? spacings * spacing : p.size[k];
        p.from[k] = (axes >> k & 1) != 0 ? -0.75 * p.size[k] : box[k];
        p.to[k] = (axes >> k & 1) != 0 ? -p.from[k] : box[dim + k];
    }
    return true;
}

/* What a scan of the points tells. */
struct scanned {
    unsigned long long heaviest, below_lightest;     /* weights, ordered; all bits of the lightest turned */
    unsigned long long high[3], below_low[3];        /* coordinates, likewise, along axes with walls */
    uint32_t infinite;                               /* is a number not finite? */
};

/* Raises a number; mostly it is high enough. */
DEVICE void raise_to(unsigned long long *at, unsigned long long value)
{
    if (*(volatile unsigned long long *)at < value) {
        atomicMax(at, value);
    }
}

__global__ void snap_kernel(const double *points, const double *weights, const period p, double *x, scanned *out)
{
    const size_t i = thread_number(), dim = (size_t)p.dim;
    bool finite = true;
    if (i >= p.count) {
        return;
    }
    for (size_t k = 0; k < dim; k++) {
        const real given = real(points[i * dim + k]) + 0.0;
        finite = finite && fabs(given.value) < HUGE_VAL;
        if ((p.axes >> k & 1) != 0) {
            const real steps = (given - p.low[k]) / p.unit[k] + 0.5;
            const double moved = fmod((real(floor(steps.value)) * p.unit[k]).value, p.size[k]);
            x[i * dim + k] = (real(moved) + (moved < 0.0 ? p.size[k] : 0.0)).value;
        } else {
            x[i * dim + k] = given.value;
            raise_to(&out->high[k], ordered(given.value));
            raise_to(&out->below_low[k], ~ordered(given.value));
        }
    }
    if (weights != NULL) {
        finite = finite && fabs(weights[i]) < HUGE_VAL;
        raise_to(&out->heaviest, ordered(weights[i]));
        raise_to(&out->below_lightest, ~ordered(weights[i]));
    }
    if (!finite) {
        out->infinite = 1;
    }
}

/* Calls f(copy) for the copies of a point in the padded box, in the order of pbw_cells.h. */
template <typename F> DEVICE void visit_copies(const period &p, const double *x, F f)
{
    int first[3] = { 0, 0, 0 }, last[3] = { 0, 0, 0 }, shift[3];
    for (int k = 0; k < p.dim; k++) {
        if ((p.axes >> k & 1) == 0) {
            continue;
        }
        first[k] = (int)ceil(((real(-p.margin[k]) - x[k]) / p.size[k]).value);
        last[k] = (int)floor(((real(p.size[k]) + p.margin[k] - x[k]) / p.size[k]).value);
    }
    for (shift[2] = first[2]; shift[2] <= last[2]; shift[2]++) {
        for (shift[1] = first[1]; shift[1] <= last[1]; shift[1]++) {
            for (shift[0] = first[0]; shift[0] <= last[0]; shift[0]++) {
                bool inside = shift[0] != 0 || shift[1] != 0 || shift[2] != 0;
                double copy[3];
                for (int k = 0; k < p.dim; k++) {
                    copy[k] = (real(x[k]) + real((double)shift[k]) * p.size[k]).value;
                    inside = inside && ((p.axes >> k & 1) == 0 || (copy[k] >= -p.margin[k]
                          && copy[k] <= (real(p.size[k]) + p.margin[k]).value));
                }
                if (inside) {
                    f(copy);
                }
            }
        }
    }
}

__global__ void count_copies_kernel(const period p, const double *x, size_t *first)
{
    const size_t i = thread_number();
    if (i < p.count) {
        size_t count = 0;
        visit_copies(p, x + i * (size_t)p.dim, [&](const double *) { count++; });
        first[i] = count;
    }
}

__global__ void write_copies_kernel(const period p, const double *x, const double *weights, const size_t *first,
                                    double *to, double *to_weights)
{
    const size_t i = thread_number(), dim = (size_t)p.dim;
    if (i < p.count) {
        size_t at = first[i];
        for (size_t k = 0; k < dim; k++) {
            to[i * dim + k] = x[i * dim + k];
        }
        if (weights != NULL) {
            to_weights[i] = weights[i];
        }
        visit_copies(p, x + i * dim, [&](const double *copy) {
            for (size_t k = 0; k < dim; k++) {
                to[(p.count + at) * dim + k] = copy[k];
            }
            if (weights != NULL) {
                to_weights[p.count + at] = weights[i];
            }
            p.source[at++] = (uint32_t)i;
        });
    }
}

/* Reads what was scanned. */
void judge_points(call &c, const scanned *on_device, bool weighted, period &p)
{
    const scanned found = read_back(c, on_device, PBW_STAGE_ORDER, 0.1);
    require(c, found.infinite == 0, PBW_ERROR_NOT_FINITE, pbw_status_string(PBW_ERROR_NOT_FINITE));
    p.heaviest = weighted ? unordered(found.heaviest) : 0.0;
    p.lightest = weighted ? unordered(~found.below_lightest) : 0.0;
    double square = p.heaviest - p.lightest;
    for (int k = 0; k < p.dim; k++) {
        const bool repeats = (p.axes >> k & 1) != 0;
        const double low = repeats ? 0.0 : std::min(p.from[k], unordered(~found.below_low[k]));
        const double high = repeats ? p.size[k] : std::max(p.to[k], unordered(found.high[k]));
        const double half = (high - low) * (repeats ? 0.75 : 1);
        p.extent[k] = high - low;
        square += half * half;
    }
    for (int k = 0; k < p.dim; k++) {                /* copies must be exact, also those that are not needed */
        const bool exact = 1.75 * p.size[k] + 1.002 * sqrt(square) < 4e15 * p.unit[k];
        require(c, exact || (p.axes >> k & 1) == 0, PBW_ERROR_ARGUMENT, "weights differ too much for a periodic box");
    }
}

/* Makes the points in units and their copies, which are left to the caller: points, weights, p.source. */
void repeat_points(call &c, const pbw_cuda_points &given, period &p, pbw_cuda_points &made)
{
    const size_t dim = (size_t)p.dim;
    const double *points = widened(c, given.points, given.is_float != 0, p.count * dim);
    const double *weights = widened(c, given.weights, given.is_float != 0, p.count);
    buffer<double> x(c, p.count * dim);
    buffer<scanned> found(c, 1);
    buffer<size_t> first(c, p.count + 1);
    fill(c, found.at, 0, 1);
    launch(c, "points", snap_kernel, over(p.count, 128), points, weights, p, x.at, found.at);
    judge_points(c, found.at, weights != NULL, p);
    fill(c, first.at + p.count, 0, 1);
    launch(c, "copies", count_copies_kernel, over(p.count, 128), p, x.at, first.at);
    with_scratch(c, "scan", [&](void *scratch, size_t &bytes) {
        return cub::DeviceScan::ExclusiveSum(scratch, bytes, first.at, first.at, p.count + 1, c.stream);
    });
    const size_t copies = read_back(c, first.at + p.count, PBW_STAGE_ORDER, 0.2);
    require(c, copies <= 4 * p.count + 100000, PBW_ERROR_BACKEND, too_uneven);
    require(c, p.count + copies < PBW_NONE - 16, PBW_ERROR_TOO_LARGE, pbw_status_string(PBW_ERROR_TOO_LARGE));
    p.total = p.count + copies;
    double *const to = allocate<double>(c, p.total * dim);
    double *const to_weights = weights != NULL ? allocate<double>(c, p.total) : NULL;
    p.source = allocate<uint32_t>(c, copies);
    launch(c, "copies", write_copies_kernel, over(p.count, 128), p, x.at, weights, first.at, to, to_weights);
    made = pbw_cuda_points{ p.dim, 0, to, to_weights, p.total, 0 };
    wait(c, PBW_STAGE_ORDER, 0.3);
    for (const void *kept : { (const void *)to, (const void *)to_weights, (const void *)p.source }) {
        release(c, kept, true);
    }
}

/* Makes the cells with copies in the margins. */
pbw_status make_periodic(const pbw_cuda_points &points, unsigned what, const pbw_options *given_options,
                         const request &r, period &p, pbw_cuda_cells *cells)
{
    pbw_cuda_mesh mesh = {};
    pbw_cuda_points made = {};
    pbw_options options = r.options;
    local_call local{};
    try {
        open_local(local, r);
        repeat_points(local.c, points, p, made);
    } catch (const failure &) {
        made = pbw_cuda_points();
        p.source = NULL;
    }
    pbw_status status = close_local(local);
    if (status == PBW_OK) {
        status = pbw_cuda_triangulate(p.dim, 0, made.points, made.weights, p.total, given_options, r.stream, r.cpu,
                                      &mesh);
        options.flags = 0;
    }
    if (mesh.simplices != NULL) {
        status = run_cells({ &mesh, &made, NULL, what, r.cpu, cells, &p }, &options, r.stream, NULL);
    }
    pbw_cuda_free(&mesh, r.stream);
    for (const void *array : { made.points, made.weights, (const void *)p.source }) {
        if (array != NULL) {
            cudaFreeAsync((void *)(uintptr_t)array, r.stream);
        }
    }
    return status;
}

} /* namespace */

extern "C" pbw_status pbw_cuda_cells_periodic(const pbw_cuda_points *points, const double *box, unsigned axes,
                                              unsigned what, const pbw_options *given_options, void *stream,
                                              pbw_triangulator *cpu, pbw_cuda_cells *cells)
{
    const pbw_cuda_mesh no_mesh = {};
    const double most = 3.2 * 64;
    request r = {};
    pbw_status status = PBW_ERROR_ARGUMENT;
    bool missing = true;
    if (cells != NULL) {
        memset(cells, 0, sizeof *cells);
    }
    if (!is_sound({ &no_mesh, points, box, what, cpu, cells, NULL }) || box == NULL || points->count == 0
        || axes == 0 || axes >> points->dim != 0 || points->count >= PBW_NONE / 2
        || !take_options(r.options, given_options)) {
        return PBW_ERROR_ARGUMENT;
    }
    r.in.dim = points->dim;
    r.stream = (cudaStream_t)stream;
    r.cpu = cpu;
    for (double spacings = 3.2; missing && spacings < most; spacings *= 2) {
        period p = {};
        p.missing = &missing;
        missing = false;
        if (!set_sizes(box, points->dim, axes, points->count, spacings, p)) {
            return PBW_ERROR_ARGUMENT;
        }
        status = make_periodic(*points, what, given_options, r, p, cells);
    }
    return status;
}
