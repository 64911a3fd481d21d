/* pbw_mpi.h - v0.2.0 - one exact triangulation by many machines, over MPI - MIT-0

   QUICK START
   In one source file, define PBW_MPI_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw.h, pbw_tiles.h and pbw_tilefile.h, with their implementations in some source file.

       pbwm_options options = { 0 };                         // dim 3, no weights, threads = cores / ranks of the node
       pbwm_report report;
       pbw_status status;
       options.output = "mesh.pbwt";
       status = pbwm_triangulate(MPI_COMM_WORLD, points, count, &options, &report);
       if (status != PBW_OK) puts(report.text);              // the same on all ranks

   In: points of each rank, any of them, with ids that are all different.  Out: the triangulation of all, a tile on
   each rank: written to one file (pbw_tilefile.h), or passed to options.emit; and its hash, which is pbw_hash of one
   machine's.

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>ranks        memory, agreement, clocks
     >>exchange     messages between all ranks
     >>points       to the rank that has their brick
     >>files        chunks and states of tiles
     >>rounds       requests, and answers to others'
     >>leftovers    rank 0 triangulates what all ranks gave up
     >>links        facets across tiles
     >>output       chunks at their places in one file
     >>triangulate  the stages in order

   FUNCTIONS
     pbwm_triangulate  triangulates points of all processes
     pbwm_agree        the same status on all processes, of the first that failed

   HOW
   Points travel to the rank whose brick has them (a sorted sample of all ranks gives the cuts); then each rank works
   through pbw_tiles.h: asks, answers, takes; rank 0 triangulates the leftovers; facets meet their other side at the
   rank that owns their vertex of the smallest id.  Ranks send messages to those only that need them.

   PROMISES  (tests/tiles.sh guards them)
     exact       the simplices, links and hash of one machine, for any number of ranks
     together    every step ends with an agreement: all ranks return the same status, with one text that names the
                 rank that failed and why
     restart     the next run continues from finished tiles: see RESTART
     bounded     options.build.memory_limit limits each rank's tile; the exchange of points before takes 50 bytes each
     sound       memory by options.build.resize; all is freed after a failure

   RESTART
   If a rank dies, all end, as in MPI without extensions: unfinished tiles need its answers.  With an output, each
   rank keeps its finished tile in a folder beside it (output.scratch: N.chunk, N.state).  A call with the same points
   and number of ranks reuses these tiles and makes the others: after a rank died while others had finished, leftovers
   did not fit, or the disk was full.  Points are read and partitioned again.  Files that are damaged, or of other
   points, are not reused: each has checksums, which are compared whenever it is read.  A run that succeeds removes
   the folder.  Its file `lock` is locked by rank 0: a second run on one output says which process works there.
   output grows under a name of its own, and has its name when it is complete.

   CONFIGURATION MACROS
     PBW_MPI_IMPLEMENTATION      in one source file: compile the implementation there
*/
#ifndef PBW_MPI_H
#define PBW_MPI_H
#include "pbw_tilefile.h"
#include <mpi.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------------------------------------
   >>interface    Types and functions.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwm_options {              /* all zero = best defaults */
    pbw_options build;                     /* of each rank's tile; threads 0 = the node's cores / its ranks; backend:
                                              each rank may have its own device */
    int dim;                               /* 2, else 3 */
    int weighted;                          /* 1: regular triangulation */
    double halo;                           /* as in pbwt_options */
    const char *output;                    /* .pbwt, or NULL; a folder that all ranks see */
    /* Called with the rank's simplices instead of writing them: see pbwt_options.  NULL = none. */
    pbw_status (*emit)(void *user, const pbwt_tile *tile, size_t first, size_t count, const uint32_t *corners,
                       const uint32_t *links);
    void *emit_user;
    /* Called once on each rank when its points are no longer read, at the latest when the call returns: it may free
       them, 40 bytes of some 350 for each.  NULL = none. */
    void (*taken)(void *user);
    void *taken_user;
} pbwm_options;

/* Points go to their ranks; their trees; the halo; the triangulation and its certificate; rounds of questions, with
   repairs and the hash. */
enum { PBWM_PARTITION, PBWM_TREE, PBWM_HALO, PBWM_BUILD, PBWM_ROUNDS, PBWM_LEFTOVERS, PBWM_LINKS, PBWM_WRITE,
       PBWM_PHASES };

typedef struct pbwm_report {               /* equal on all ranks */
    uint64_t points, duplicates, simplices, hull, hash;      /* hull: facets, 0 without an output */
    uint64_t halo, sent_bytes, given_up;   /* points of others, bytes after the partition, leftovers: sums */
    uint64_t rounds, largest;              /* of questions; points of one rank: the most */
    uint64_t resumed;                      /* tiles that an earlier run had finished */
    uint64_t memory;                       /* bytes resident at one time in one process: the most of all ranks */
    double seconds[PBWM_PHASES];           /* of the slowest rank */
    double busy[3];                        /* seconds at work on tiles, no waiting: least, mean, most */
    char text[1400];                       /* why it failed */
} pbwm_report;

/* Called by all ranks of comm at once.  points: read only.  Fails as pbwt_tree_make, pbwt_ask and files do. */
PBWDEF pbw_status pbwm_triangulate(MPI_Comm comm, const pbwt_point *points, size_t count,
                                   const pbwm_options *options, pbwm_report *report);
/* For steps before and after it: returns PBW_OK if all ranks pass that, else, on all ranks, the status and the text
   of the lowest rank that does not. */
PBWDEF pbw_status pbwm_agree(MPI_Comm comm, pbw_status status, char *text, size_t text_size);

#ifdef __cplusplus
}
#endif
#endif /* PBW_MPI_H */

#if defined(PBW_MPI_IMPLEMENTATION) && !defined(PBWM__IMPLEMENTED)
#define PBWM__IMPLEMENTED

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* ------------------------------------------------------------------------------------------------------
   >>ranks        Memory, agreement, clocks.
   In: a status of each rank.  Out: the status and the text of the lowest rank that failed, on all.
   ------------------------------------------------------------------------------------------------------ */
typedef struct pbwm__group {
    MPI_Comm comm;
    MPI_Datatype word;                               /* 8 bytes, so that an int counts 16 GB */
    int rank, ranks, dim;
    pbwm_options options;
    pbw_memory memory;                               /* of exchanges; without a limit, which is that of the tile */
    pbwm_report *report;
    double began;
    int *count;                                      /* of exchanges: 2 a rank */
    MPI_Request *request;                            /* 2 a rank */
} pbwm__group;

/* Allocates zeros; the size is stored before the block. */
static void *pbwm__take(pbwm__group *g, size_t bytes)
{
    const size_t all = bytes + 16;
    char *block = (char *)pbw_memory_resize(&g->memory, NULL, 0, all, 1);
    if (block == NULL) {
        return NULL;
    }
    memset(block, 0, all);
    memcpy(block, &all, sizeof all);
    return block + 16;
}

static void pbwm__give(pbwm__group *g, void *data)
{
    char *block;
    size_t all;
    if (data != NULL) {
        block = (char *)data - 16;
        memcpy(&all, block, sizeof all);
        (void)pbw_memory_resize(&g->memory, block, all, 0, 1);
    }
}

PBWDEF pbw_status pbwm_agree(MPI_Comm comm, pbw_status status, char *text, size_t text_size)
{
    int rank, ranks, mine, least, all = (int)status;
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &ranks);
    mine = status != PBW_OK ? rank : ranks;
    MPI_Allreduce(&mine, &least, 1, MPI_INT, MPI_MIN, comm);
    if (least == ranks) {
        return PBW_OK;
    }
    MPI_Bcast(&all, 1, MPI_INT, least, comm);
    MPI_Bcast(text, (int)text_size, MPI_CHAR, least, comm);
    return (pbw_status)all;
}

/* pbwm_agree with the report's text, which is empty if all is well. */
static pbw_status pbwm__agree_text(pbwm__group *g, pbw_status status)
{
    status = pbwm_agree(g->comm, status, g->report->text, sizeof g->report->text);
    if (status == PBW_OK) {
        g->report->text[0] = 0;
    }
    return status;
}

/* pbwm_agree with a text that names this rank and its step. */
static pbw_status pbwm__agree(pbwm__group *g, pbw_status status, const char *what)
{
    snprintf(g->report->text, sizeof g->report->text, "rank %d: %s: %s", g->rank, what, pbw_status_string(status));
    return pbwm__agree_text(g, status);
}

/* pbwm__agree for a step that can fail only by a file. */
static pbw_status pbwm__agree_file(pbwm__group *g, int good, const char *what)
{
    const pbw_status status = good ? PBW_OK : PBW_ERROR_BACKEND;
    snprintf(g->report->text, sizeof g->report->text, "rank %d: %s: %s", g->rank, what,
             errno != 0 ? strerror(errno) : "cannot write");
    return pbwm__agree_text(g, status);
}

static void pbwm__end_phase(pbwm__group *g, int which)
{
    const double now = MPI_Wtime();
    g->report->seconds[which] += now - g->began;
    g->began = now;
}

/* ------------------------------------------------------------------------------------------------------
   >>exchange     Messages between all ranks.
   In: out[p], whole words for rank p.  Out: in[p], the words from rank p, and in[ranks], the block that has all of
   them, for the caller to free.  First all ranks exchange sizes; then messages go where there are any.
   ------------------------------------------------------------------------------------------------------ */
static pbw_status pbwm__exchange(pbwm__group *g, const pbwt_bytes *out, pbwt_bytes *in)
{
    int *send = g->count, *get = g->count + g->ranks, p, n = 0;
    size_t all = 0;
    pbw_status status = PBW_OK;
    for (p = 0; p < g->ranks; p++) {
        status = out[p].size / 8 > 0x7fffffff ? PBW_ERROR_TOO_LARGE : status;
        send[p] = status == PBW_OK ? (int)(out[p].size / 8) : 0;
    }
    MPI_Alltoall(send, 1, MPI_INT, get, 1, MPI_INT, g->comm);
    for (p = 0; p < g->ranks; p++) {
        all += 8 * (size_t)get[p];
    }
    in[g->ranks].size = all;
    in[g->ranks].data = (char *)pbwm__take(g, all);
    status = status == PBW_OK && in[g->ranks].data == NULL ? PBW_ERROR_MEMORY : status;
    status = pbwm__agree(g, status, "room for messages");
    for (p = 0, all = 0; p < g->ranks && status == PBW_OK; p++) {
        in[p].data = in[g->ranks].data + all;
        in[p].size = 8 * (size_t)get[p];
        all += in[p].size;
        if (get[p] > 0) {
            MPI_Irecv(in[p].data, get[p], g->word, p, 1, g->comm, g->request + n++);
        }
    }
    for (p = 0; p < g->ranks && status == PBW_OK; p++) {
        if (send[p] > 0) {
            MPI_Isend(out[p].data, send[p], g->word, p, 1, g->comm, g->request + n++);
        }
    }
    MPI_Waitall(n, g->request, MPI_STATUSES_IGNORE);
    if (status != PBW_OK) {
        pbwm__give(g, in[g->ranks].data);
        in[g->ranks].data = NULL;
    }
    return status;
}

/* Sorts records into one string for each rank; to[i]: of record i; out[ranks]: the block.  Returns 0 without
   memory. */
static int pbwm__sort_out(pbwm__group *g, const void *records, size_t count, size_t size, const int *to,
                          pbwt_bytes *out)
{
    char *block = (char *)pbwm__take(g, count * size);
    size_t i;
    int p;
    memset(out, 0, ((size_t)g->ranks + 1) * sizeof *out);
    out[g->ranks].data = block;
    for (i = 0; i < count && block != NULL; i++) {
        out[to[i]].size += size;
    }
    for (p = 0; p < g->ranks; p++) {
        out[p].data = block;
        block += block != NULL ? out[p].size : 0;
        out[p].size = 0;
    }
    for (i = 0; i < count && block != NULL; i++) {
        pbwt_bytes *o = out + to[i];
        memcpy(o->data + o->size, (const char *)records + i * size, size);
        o->size += size;
    }
    return block != NULL;
}

/* Sorts records out and exchanges them; in[ranks]: those that came, and their bytes. */
static pbw_status pbwm__send_records(pbwm__group *g, const void *records, size_t count, size_t size, const int *to,
                                     pbwt_bytes *in)
{
    pbwt_bytes *out = (pbwt_bytes *)pbwm__take(g, ((size_t)g->ranks + 1) * sizeof *out);
    const int room = out != NULL && to != NULL && pbwm__sort_out(g, records, count, size, to, out);
    pbw_status status = pbwm__agree(g, room ? PBW_OK : PBW_ERROR_MEMORY, "room for records");
    status = status == PBW_OK ? pbwm__exchange(g, out, in) : status;
    if (out != NULL) {
        pbwm__give(g, out[g->ranks].data);
    }
    pbwm__give(g, out);
    return status;
}

/* Gives a string of this rank to all (root < 0) or to one; *all: the strings of all ranks, one after the other. */
static pbw_status pbwm__join(pbwm__group *g, const pbwt_bytes *mine, int root, pbwt_bytes *all)
{
    pbwt_bytes *out = (pbwt_bytes *)pbwm__take(g, (2 * (size_t)g->ranks + 1) * sizeof *out);
    pbwt_bytes *in = out != NULL ? out + g->ranks : NULL;
    pbw_status status = pbwm__agree(g, out != NULL ? PBW_OK : PBW_ERROR_MEMORY, "room for a list of ranks");
    int p;
    for (p = 0; p < g->ranks && status == PBW_OK; p++) {
        out[p] = *mine;
        out[p].size = root < 0 || p == root ? mine->size : 0;
    }
    status = status == PBW_OK ? pbwm__exchange(g, out, in) : status;
    if (status == PBW_OK) {
        *all = in[g->ranks];
    }
    pbwm__give(g, out);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>points       To the rank that has their brick.
   In: points of each rank, any of them.  Out: on each rank a tree of the points in its brick.
   Holds: cuts are those of one sample, the same on all ranks.
   ------------------------------------------------------------------------------------------------------ */
#define PBWM__MOST_RANKS 65536

typedef struct pbwm__chunk {                         /* in a file of its own until its place is known */
    pbwtf_writer writer;
    pbwtf_entry entry;
    char name[1150], state[1150];                    /* state: of a finished tile */
    FILE *file;
} pbwm__chunk;

typedef struct pbwm__state {                         /* then arrays of the tile: foreign, facets, leftovers, border */
    char magic[8];                                   /* "PBWMTIL2" */
    uint64_t key, arrays;                            /* of all points and trees; the sum of the arrays */
    uint64_t foreign, facets, leftovers, border;
    pbwt_numbers numbers;
    pbwtf_chunk chunk;
    uint64_t checksum;                               /* of what is before */
} pbwm__state;

typedef struct pbwm__work {
    pbwm__group *g;
    uint64_t given;                                  /* points of all ranks, duplicates included */
    pbwt_bytes mine;                                 /* points of this rank's brick, until the tree has them */
    pbwt_bytes *message;                             /* 4 (ranks + 1) strings; the last ranks + 1 are empty */
    pbwt_served *served;
    pbwt_summary *summary;
    pbwt_tree tree;
    pbwt_tile tile, rest;                            /* rest: leftovers, on rank 0 */
    pbwt_options tile_options;
    pbwm__chunk chunk, leftover;
    pbwt_bytes matched;                              /* facets of tile and rest */
    uint64_t hull;                                   /* that this rank matched */
    uint64_t key;                                    /* see pbwm__state */
    double busy;                                     /* seconds in pbwt_ask */
    int finished, resumed;                           /* the tile is; by an earlier run */
    char *kept;                                      /* arrays of such a tile */
    char part[1150];                                 /* the output while it grows */
    char scratch[1100];                              /* the folder */
    int lock, is_made;                               /* of rank 0: the folder's lock, or -1; part is there */
} pbwm__work;

/* Cuts by a sorted sample of all ranks: 4096 points of each, or fewer, so that all together stay small. */
static pbw_status pbwm__cut(pbwm__work *w, const pbwt_point *points, size_t count, pbwt_cut *cuts)
{
    pbwm__group *g = w->g;
    const size_t most = g->ranks > 256 ? 256 : 4096, some = count < most ? count : most;
    pbwt_point *sample = (pbwt_point *)pbwm__take(g, some * sizeof *sample);
    pbwt_bytes mine, all = { NULL, 0 };
    pbw_status status;
    size_t i;
    for (i = 0; i < some && sample != NULL; i++) {
        sample[i] = points[pbw_random(i, 0) % count];
    }
    status = pbwm__agree(g, sample != NULL ? PBW_OK : PBW_ERROR_MEMORY, "room for a sample");
    mine.data = (char *)sample;
    mine.size = some * sizeof *sample;
    status = status == PBW_OK ? pbwm__join(g, &mine, -1, &all) : status;
    if (status == PBW_OK) {
        pbwt_cut_points(g->dim, (pbwt_point *)(void *)all.data, all.size / sizeof *sample, g->ranks, cuts);
    }
    pbwm__give(g, all.data);
    pbwm__give(g, sample);
    return status;
}

/* The exchange of points: each rank sends each other rank its points in bundles of one size, except the last, in
   order. The receiver knows how many come and where they belong. */
typedef struct pbwm__moving {
    size_t most;                                     /* points in a bundle */
    pbwt_point *bundle;                              /* two for each rank: one is filled while the other goes */
    MPI_Request *going, *coming;                     /* of bundles; of what comes */
    uint64_t *send, *get;                            /* points for each rank, and from it */
    size_t comings;
} pbwm__moving;

/* Posts the receives of all bundles, straight to their places, rank by rank; *own: the place for this rank's points.
   */
static void pbwm__expect(pbwm__group *g, pbwm__moving *m, pbwt_point *place, pbwt_point **own)
{
    const int words = (int)(sizeof *place / 8);
    int p;
    for (p = 0; p < g->ranks; p++) {
        size_t left = (size_t)m->get[p], some;
        if (p == g->rank) {
            *own = place;
            place += left;
            continue;
        }
        for (; left > 0; left -= some, place += some) {
            some = left < m->most ? left : m->most;
            MPI_Irecv(place, (int)some * words, g->word, p, 1, g->comm, m->coming + m->comings++);
        }
    }
}

/* Sends the bundle of rank p that has `filled` points of all that went into its bundles. */
static void pbwm__send_bundle(pbwm__group *g, pbwm__moving *m, int p, size_t filled)
{
    const size_t which = 2 * (size_t)p + (filled - 1) / m->most % 2, some = (filled - 1) % m->most + 1;
    MPI_Isend(m->bundle + which * m->most, (int)(some * sizeof *m->bundle / 8), g->word, p, 1, g->comm,
              m->going + which);
    MPI_Wait(m->going + (which ^ 1), MPI_STATUS_IGNORE);     /* the other is to be filled next */
}

/* Sends points[i] to rank to[i].  Returns once all points for this rank have arrived. */
static void pbwm__move(pbwm__group *g, pbwm__moving *m, const pbwt_point *points, size_t count, const int *to,
                       pbwt_point *own)
{
    size_t i;
    int p;
    memset(m->send, 0, (size_t)g->ranks * sizeof *m->send);
    for (i = 0; i < count; i++) {
        const size_t filled = (size_t)m->send[to[i]];
        if (to[i] == g->rank) {
            *own++ = points[i];
            continue;
        }
        m->bundle[(2 * (size_t)to[i] + filled / m->most % 2) * m->most + filled % m->most] = points[i];
        if (++m->send[to[i]] % m->most == 0) {
            pbwm__send_bundle(g, m, to[i], filled + 1);
        }
    }
    for (p = 0; p < g->ranks; p++) {
        if (m->send[p] % m->most != 0) {
            pbwm__send_bundle(g, m, p, (size_t)m->send[p]);
        }
    }
    MPI_Waitall(2 * g->ranks, m->going, MPI_STATUSES_IGNORE);
    MPI_Waitall((int)m->comings, m->coming, MPI_STATUSES_IGNORE);
}

/* Takes room for what comes, so many bundles. */
static int pbwm__take_room(pbwm__work *w, pbwm__moving *m)
{
    pbwm__group *g = w->g;
    size_t all = 0, bundles = 0;
    int p;
    for (p = 0; p < g->ranks; p++) {
        all += (size_t)m->get[p];
        bundles += (size_t)m->get[p] / m->most + 1;
        m->going[2 * p] = m->going[2 * p + 1] = MPI_REQUEST_NULL;
    }
    w->mine.size = all * sizeof(pbwt_point);
    w->mine.data = (char *)pbwm__take(g, w->mine.size);
    m->coming = (MPI_Request *)pbwm__take(g, bundles * sizeof *m->coming);
    m->bundle = (pbwt_point *)pbwm__take(g, 2 * (size_t)g->ranks * m->most * sizeof *m->bundle);
    return bundles < 0x7fffffff && w->mine.data != NULL && m->coming != NULL && m->bundle != NULL;
}

/* Gives each point to the rank to[i]. */
static pbw_status pbwm__exchange_points(pbwm__work *w, const pbwt_point *points, size_t count, const int *to)
{
    const size_t ranks = (size_t)w->g->ranks;
    pbwm__group *g = w->g;
    pbwt_point *own = NULL;
    pbwm__moving m;
    pbw_status status;
    size_t i;
    memset(&m, 0, sizeof m);
    m.most = ranks < 256 ? 65536 / ranks : 256;
    m.send = (uint64_t *)pbwm__take(g, 2 * ranks * sizeof *m.send);
    m.going = (MPI_Request *)pbwm__take(g, 2 * ranks * sizeof *m.going);
    status = pbwm__agree(g, m.send != NULL && m.going != NULL ? PBW_OK : PBW_ERROR_MEMORY,
                         "room for a list of ranks");
    if (status == PBW_OK) {
        m.get = m.send + ranks;
        for (i = 0; i < count; i++) {
            m.send[to[i]]++;
        }
        MPI_Alltoall(m.send, 1, g->word, m.get, 1, g->word, g->comm);
        status = pbwm__agree(g, pbwm__take_room(w, &m) ? PBW_OK : PBW_ERROR_MEMORY, "room for its points");
    }
    if (status == PBW_OK) {
        pbwm__expect(g, &m, (pbwt_point *)(void *)w->mine.data, &own);
        pbwm__move(g, &m, points, count, to, own);
    }
    pbwm__give(g, m.bundle);
    pbwm__give(g, m.coming);
    pbwm__give(g, m.going);
    pbwm__give(g, m.send);
    return status;
}

static pbw_status pbwm__partition(pbwm__work *w, const pbwt_point *points, size_t count)
{
    pbwm__group *g = w->g;
    pbwt_cut *cuts = (pbwt_cut *)pbwm__take(g, (size_t)g->ranks * sizeof *cuts);
    int *to = (int *)pbwm__take(g, count * sizeof *to);
    pbw_status status = pbwm__agree(g, cuts != NULL && to != NULL ? PBW_OK : PBW_ERROR_MEMORY, "room for the cuts");
    size_t i;
    status = status == PBW_OK ? pbwm__cut(w, points, count, cuts) : status;
    for (i = 0; i < count && status == PBW_OK; i++) {
        to[i] = pbwt_part(g->dim, cuts, g->ranks, points + i);
    }
    status = status == PBW_OK ? pbwm__exchange_points(w, points, count, to) : status;
    pbwm__give(g, to);
    pbwm__give(g, cuts);
    pbwm__end_phase(g, PBWM_PARTITION);
    if (g->options.taken != NULL) {
        g->options.taken(g->options.taken_user);
        g->options.taken = NULL;
    }
    return status;
}

static pbw_status pbwm__plant(pbwm__work *w)
{
    pbwm__group *g = w->g;
    const int words = (int)(sizeof(pbwt_summary) / 8);
    pbwt_summary mine;
    pbw_status status = pbwt_tree_make(g->dim, g->rank, (const pbwt_point *)(const void *)w->mine.data,
                                       w->mine.size / sizeof(pbwt_point), &g->options.build, &w->tree);
    status = pbwm__agree(g, status, "its points");
    pbwm__give(g, w->mine.data);
    w->mine.data = NULL;
    if (status == PBW_OK) {
        pbwt_summarise(&w->tree, &mine);
        MPI_Allgather(&mine, words, g->word, w->summary, words, g->word, g->comm);
    }
    pbwm__end_phase(g, PBWM_TREE);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>files        Chunks and states of tiles.
   In: a finished tile.  Out: its chunk, in a file of its own until its place in the output is known; its state, for a
   run that goes on.
   ------------------------------------------------------------------------------------------------------ */
static uint32_t pbwm__flags(const pbwm__group *g)
{
    return (g->options.weighted ? PBWTF_WEIGHTS : 0) | PBWTF_LINKS;
}

/* Of the points of all ranks, in their order in the trees, the dimension and weights.  All ranks call it. */
static uint64_t pbwm__key(const pbwm__work *w)
{
    const pbwm__group *g = w->g;
    const uint64_t own = pbwtf_checksum((uint64_t)g->rank + 1, w->tree.points, w->tree.count * sizeof(pbwt_point));
    uint64_t mine = pbw_random(own, 0), all;
    MPI_Allreduce(&mine, &all, 1, MPI_UINT64_T, MPI_SUM, g->comm);
    return pbw_random(all + ((uint64_t)g->ranks << 8 | (uint64_t)g->dim << 4 | pbwm__flags(g)), 0);
}

static size_t pbwm__state_size(const pbwm__state *state)            /* of the arrays after it, whole words */
{
    return (size_t)(state->foreign * sizeof(pbwt_vertex) + state->facets * sizeof(pbwt_facet)
                    + (state->leftovers + state->border + 1) / 2 * 8);
}

/* Copies the arrays of a tile to one block, or sets the tile's to such a block. */
static void pbwm__place_arrays(pbwt_tile *tile, char *block, int copy)
{
    char *facets = block + tile->foreign_count * sizeof *tile->foreign;
    char *leftovers = facets + tile->facet_count * sizeof *tile->facets;
    char *border = leftovers + tile->leftover_count * sizeof *tile->leftovers;
    if (copy && tile->foreign_count > 0) {
        memcpy(block, tile->foreign, (size_t)(facets - block));
    }
    if (copy && tile->facet_count > 0) {
        memcpy(facets, tile->facets, (size_t)(leftovers - facets));
    }
    if (copy && tile->leftover_count > 0) {
        memcpy(leftovers, tile->leftovers, (size_t)(border - leftovers));
    }
    if (copy && tile->border_count > 0) {
        memcpy(border, tile->border, tile->border_count * sizeof *tile->border);
    }
    if (!copy) {
        tile->foreign = (const pbwt_vertex *)(void *)block;
        tile->facets = (const pbwt_facet *)(void *)facets;
        tile->leftovers = (const uint32_t *)(void *)leftovers;
        tile->border = (const uint32_t *)(void *)border;
    }
}

static uint64_t pbwm__state_sum(const pbwm__state *state)
{
    return pbwtf_checksum(0, state, offsetof(pbwm__state, checksum));
}

/* Ends the chunk, and writes the state.  Returns 0 if they cannot be written, or without memory. */
static int pbwm__keep(pbwm__work *w)
{
    pbwt_tile *tile = &w->tile;
    pbwm__state state;
    char part[1200], *block;
    FILE *file = NULL;
    size_t size;
    int good = pbwtf_end(&w->chunk.writer, tile, w->g->dim);
    memset(&state, 0, sizeof state);
    memcpy(state.magic, "PBWMTIL2", 8);
    state.key = w->key;
    state.foreign = tile->foreign_count;
    state.facets = tile->facet_count;
    state.leftovers = tile->leftover_count;
    state.border = tile->border_count;
    state.numbers = tile->numbers;
    state.chunk = w->chunk.writer.chunk;
    size = pbwm__state_size(&state);
    block = (char *)pbwm__take(w->g, size);
    if (good && block != NULL) {
        pbwm__place_arrays(tile, block, 1);
        state.arrays = pbwtf_sum(block, size);
        state.checksum = pbwm__state_sum(&state);
        file = pbwtf_create(w->chunk.state, part, sizeof part);
    }
    good = file != NULL && fwrite(&state, sizeof state, 1, file) == 1 && fwrite(block, 1, size, file) == size;
    good = (file == NULL || fclose(file) == 0) && good;
    pbwm__give(w->g, block);
    good = good && rename(part, w->chunk.state) == 0;
    if (file != NULL && !good) {
        remove(part);
    }
    return good;
}

/* Returns whether the chunk in its file is what the state says. */
static int pbwm__is_whole(const char *name, const pbwtf_chunk *chunk)
{
    const size_t head = sizeof *chunk, across = pbwtf_across_offset(chunk);
    char error[PBWTF_ERROR];
    pbwtf_map map;
    int good = pbwtf_map_file(name, NULL, &map, error) == PBW_OK;
    if (good) {
        good = map.size == pbwtf_chunk_size(chunk) && memcmp(pbwtf_fetch(&map, map.data, map.size), chunk, head) == 0
            && pbwtf_fault(&map) == NULL
            && pbwtf_checksum(0, map.data + head, across - head) == chunk->checksum;
        pbwtf_unmap(&map);
    }
    return good;
}

static void pbwm__recall_tile(pbwm__work *w, const pbwm__state *state)
{
    pbwt_tile *tile = &w->tile;
    tile->dim = w->g->dim;
    tile->parts = w->g->ranks;
    tile->tree = &w->tree;
    tile->request = w->message + 3 * (w->g->ranks + 1);      /* stay empty */
    tile->foreign_count = (size_t)state->foreign;
    tile->facet_count = (size_t)state->facets;
    tile->leftover_count = (size_t)state->leftovers;
    tile->border_count = (size_t)state->border;
    tile->hash = state->chunk.hash;
    tile->numbers = state->numbers;
    pbwm__place_arrays(tile, w->kept, 0);
    w->chunk.writer.chunk = state->chunk;
}

/* Takes up the tile of an earlier run.  Returns 0 if there is none of these points that is whole. */
static int pbwm__recall(pbwm__work *w)
{
    const pbwm__chunk *c = &w->chunk;
    pbwm__state state;
    size_t size = 0;
    FILE *file = fopen(c->state, "rb");
    int good = file != NULL && fread(&state, sizeof state, 1, file) == 1
            && memcmp(state.magic, "PBWMTIL2", 8) == 0 && state.checksum == pbwm__state_sum(&state)
            && state.key == w->key && pbwm__is_whole(c->name, &state.chunk);
    if (good) {
        size = pbwm__state_size(&state);
        w->kept = (char *)pbwm__take(w->g, size);
        good = w->kept != NULL && fread(w->kept, 1, size, file) == size
            && pbwtf_sum(w->kept, size) == state.arrays;
    }
    if (good) {
        pbwm__recall_tile(w, &state);
    }
    if (file != NULL) {
        fclose(file);
    }
    return good;
}

static void pbwm__name_chunk(const pbwm__work *w, pbwm__chunk *c, int number)
{
    snprintf(c->name, sizeof c->name, "%s/%d.chunk", w->scratch, number);
    snprintf(c->state, sizeof c->state, "%s/%d.state", w->scratch, number);
}

/* A chunk of this run is a new file: a process of a run that was killed may still write into that of its own. */
static void pbwm__open_chunk(pbwm__work *w, pbwm__chunk *c, const pbwt_tree *tree, int number)
{
    pbwm__name_chunk(w, c, number);
    w->resumed = tree != NULL && pbwm__recall(w);
    w->finished = w->resumed;
    if (!w->resumed) {
        remove(c->state);
        remove(c->name);
    }
    c->file = fopen(c->name, w->resumed ? "rb+" : "w+bx");
    if (c->file != NULL && !w->resumed) {
        pbwtf_begin(&c->writer, c->file, tree, (uint32_t)number, pbwm__flags(w->g));
    }
}

static void pbwm__drop_chunk(pbwm__chunk *c, int keep)
{
    if (c->file != NULL) {
        fclose(c->file);
        c->file = NULL;
        if (!keep) {
            remove(c->name);
            remove(c->state);
        }
    }
}

/* Removes, or only looks for, files of ranks from that number on.  Returns whether there were any. */
static int pbwm__old_files(const pbwm__work *w, int number, int is_removed)
{
    pbwm__chunk c;
    int any = 0, i;
    for (; number < PBWM__MOST_RANKS; number++) {
        const char *const name[2] = { c.name, c.state };
        pbwm__name_chunk(w, &c, number);
        for (i = 0; i < 2; i++) {
            any |= is_removed ? remove(name[i]) == 0 : access(name[i], F_OK) == 0;
        }
    }
    return any;
}

/* Rank 0 makes and locks the folder of scratch files. */
static pbw_status pbwm__enter(pbwm__work *w)
{
    pbwm__group *g = w->g;
    char error[PBWTF_ERROR];
    int good = 1, is_foreign = 0;
    error[0] = 0;
    snprintf(w->scratch, sizeof w->scratch, "%s.scratch", g->options.output);
    if (g->rank == 0) {
        good = pbwtf_enter(w->scratch, &w->lock, &is_foreign, error) == PBW_OK;
    }
    if (good && is_foreign && pbwm__old_files(w, 0, 0)) {
        snprintf(error, sizeof error, "%.300s has files of other programs with names of scratch files",
                 w->scratch);
        pbwtf_leave(w->scratch, w->lock, 1);
        w->lock = -1;
        good = 0;
    }
    snprintf(g->report->text, sizeof g->report->text, "rank %d: %s", g->rank, error);
    return pbwm__agree_text(g, good ? PBW_OK : PBW_ERROR_BACKEND);
}

/* Ends the files of the folder, and leaves it: it stays if a tile is kept for the next run. */
static void pbwm__leave(pbwm__work *w, pbw_status status)
{
    pbwm__group *g = w->g;
    int mine = status != PBW_OK && w->finished, any = 0;
    pbwm__drop_chunk(&w->chunk, mine);
    pbwm__drop_chunk(&w->leftover, 0);
    MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, g->comm);
    if (w->lock >= 0) {
        if (!any) {                                  /* those of an earlier run of more ranks */
            (void)pbwm__old_files(w, g->ranks, 1);
        }
        pbwtf_leave(w->scratch, w->lock, !any);
    }
}

static pbw_status pbwm__open_files(pbwm__work *w)
{
    pbwm__group *g = w->g;
    pbw_status status = pbwm__enter(w);
    if (status != PBW_OK) {
        return status;
    }
    w->key = pbwm__key(w);
    errno = 0;
    if (g->rank == 0) {
        pbwm__open_chunk(w, &w->leftover, NULL, g->ranks);
    }
    pbwm__open_chunk(w, &w->chunk, &w->tree, g->rank);
    w->tile_options.emit = pbwtf_emit;
    w->tile_options.emit_user = &w->chunk.writer;
    return pbwm__agree_file(g, w->chunk.file != NULL && (g->rank != 0 || w->leftover.file != NULL), w->chunk.name);
}

/* ------------------------------------------------------------------------------------------------------
   >>rounds       Requests, and answers to others'.
   In: the requests of the tile of each rank.  Out: replies, until no rank has a question.
   ------------------------------------------------------------------------------------------------------ */
/* One round: requests go out, answers come back. */
static pbw_status pbwm__round(pbwm__work *w)
{
    pbwm__group *g = w->g;
    pbwt_bytes *asked = w->message, *reply = asked + g->ranks + 1, *got = reply + g->ranks + 1;
    pbw_status status = pbwm__exchange(g, w->tile.request, asked), own = PBW_OK;
    int p;
    if (status != PBW_OK) {
        return status;
    }
    for (p = 0; p < g->ranks && own == PBW_OK; p++) {
        if (asked[p].size > 0) {
            own = pbwt_answer(&w->tree, w->served + p, asked + p, NULL, w->summary[p].count, reply + p);
        }
    }
    status = pbwm__agree(g, own, "an answer");
    pbwm__give(g, asked[g->ranks].data);
    status = status == PBW_OK ? pbwm__exchange(g, reply, got) : status;
    for (p = 0; p < g->ranks; p++) {
        pbwt_bytes_free(&w->tree, reply + p);
    }
    if (status != PBW_OK) {
        return status;
    }
    for (p = 0; p < g->ranks && own == PBW_OK; p++) {
        own = got[p].size > 0 ? pbwt_take(&w->tile, p, got[p].data, got[p].size) : PBW_OK;
    }
    pbwm__give(g, got[g->ranks].data);
    return pbwm__agree(g, own, "taking answers");
}

/* Works until the tile has questions or is finished; keeps it then. */
static pbw_status pbwm__work_on(pbwm__work *w, int *more)
{
    pbwm__group *g = w->g;
    const double start = MPI_Wtime();
    pbw_status status;
    char what[160];
    int good = 1;
    *more = 0;
    status = w->resumed ? PBW_OK : pbwt_ask(&w->tile, more);
    w->busy += MPI_Wtime() - start;
    snprintf(what, sizeof what, "its tile of %zu point%s, and %zu of others", w->tree.count,
             w->tree.count == 1 ? "" : "s", w->tile.foreign_count);
    status = pbwm__agree(g, status, what);
    if (status == PBW_OK && g->options.output != NULL) {
        if (!*more && !w->finished) {
            good = pbwm__keep(w);
            w->finished = good;
        }
        status = pbwm__agree_file(g, good, w->chunk.name);
    }
    return status;
}

static pbw_status pbwm__make_tile(pbwm__work *w)
{
    pbwm__group *g = w->g;
    pbw_status status = w->resumed ? PBW_OK : pbwt_open(&w->tile, &w->tree, w->summary, g->ranks, &w->tile_options);
    int more, any = 1, rounds = 0, p;
    status = pbwm__agree(g, status, "opening its tile");
    while (status == PBW_OK && any) {
        status = pbwm__work_on(w, &more);
        if (rounds++ == 1) {
            pbwm__end_phase(g, PBWM_BUILD);
        }
        if (status == PBW_OK) {
            MPI_Allreduce(&more, &any, 1, MPI_INT, MPI_MAX, g->comm);
            status = any ? pbwm__round(w) : PBW_OK;
        }
        if (rounds == 1) {
            pbwm__end_phase(g, PBWM_HALO);
        }
    }
    for (p = 0; p < g->ranks; p++) {
        pbwt_served_free(&w->tree, w->served + p);
    }
    pbwm__end_phase(g, PBWM_ROUNDS);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>leftovers    Rank 0 triangulates what all ranks gave up.
   In: what tiles know of these vertices.  Out: a chunk more, on rank 0.
   ------------------------------------------------------------------------------------------------------ */
static int pbwm__compare_ids(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

/* The ids of all points given up, ascending, on all ranks. */
static pbw_status pbwm__given_ids(pbwm__work *w, pbwt_bytes *ids)
{
    pbwm__group *g = w->g;
    const size_t count = w->tile.leftover_count;
    uint64_t *own = (uint64_t *)pbwm__take(g, count * sizeof *own);
    pbw_status status = pbwm__agree(g, own != NULL ? PBW_OK : PBW_ERROR_MEMORY, "room for leftovers");
    pbwt_bytes mine;
    size_t i;
    for (i = 0; i < count && status == PBW_OK; i++) {
        own[i] = w->tree.points[w->tile.leftovers[i]].id;
    }
    mine.data = (char *)own;
    mine.size = count * sizeof *own;
    status = status == PBW_OK ? pbwm__join(g, &mine, -1, ids) : status;
    if (status == PBW_OK) {
        qsort(ids->data, ids->size / 8, 8, pbwm__compare_ids);
    }
    pbwm__give(g, own);
    return status;
}

static pbw_status pbwm__leftovers(pbwm__work *w)
{
    pbwm__group *g = w->g;
    pbwt_bytes ids = { NULL, 0 }, mine = { NULL, 0 }, known = { NULL, 0 };
    pbwt_options options = w->tile_options;
    pbw_status status = pbwm__given_ids(w, &ids);
    char what[120];
    if (status == PBW_OK && ids.size > 0) {
        status = pbwt_leftovers(&w->tile, (uint64_t *)(void *)ids.data, ids.size / 8, &mine);
        status = pbwm__agree(g, status, "what it knows of leftovers");
        status = status == PBW_OK ? pbwm__join(g, &mine, 0, &known) : status;
        pbwt_bytes_free(&w->tree, &mine);
        if (status == PBW_OK) {
            options.emit_user = g->options.output != NULL ? &w->leftover.writer : options.emit_user;
            status = g->rank == 0 ? pbwt_finish(&w->rest, g->dim, g->ranks, &known, &options) : PBW_OK;
            snprintf(what, sizeof what, "the points given up, %zu, which need one machine", ids.size / 8);
            status = pbwm__agree(g, status, what);
        }
    }
    pbwm__give(g, known.data);
    pbwm__give(g, ids.data);
    pbwm__end_phase(g, PBWM_LEFTOVERS);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>links        Facets across tiles.
   In: facets of each tile.  Out: the same, matched: they meet at the rank that owns the vertex of the lowest id, and
   go back.
   ------------------------------------------------------------------------------------------------------ */
static int pbwm__compare_facets(const void *a, const void *b)        /* the order in which a tile has them */
{
    const uint64_t x = ((const pbwt_facet *)a)->from, y = ((const pbwt_facet *)b)->from;
    return x < y ? -1 : x > y;
}

/* Sends facets there, to the owner of their lowest id, or back. */
static pbw_status pbwm__send_facets(pbwm__work *w, pbwt_bytes *facets, int back)
{
    pbwm__group *g = w->g;
    const size_t count = facets->size / sizeof(pbwt_facet);
    const pbwt_facet *facet = (const pbwt_facet *)(const void *)facets->data;
    int *to = (int *)pbwm__take(g, count * sizeof *to);
    pbw_status status;
    size_t i;
    for (i = 0; i < count && to != NULL; i++) {      /* leftovers, tile `ranks`, are on rank 0 */
        to[i] = (int)((back ? facet[i].from >> 40 : facet[i].to) % (uint64_t)g->ranks);
    }
    status = pbwm__send_records(g, facet, count, sizeof *facet, to, w->message);
    pbwm__give(g, to);
    pbwm__give(g, facets->data);
    facets->data = NULL;
    if (status == PBW_OK) {
        *facets = w->message[g->ranks];
    }
    return status;
}

static pbw_status pbwm__match(pbwm__work *w)
{
    pbwm__group *g = w->g;
    const size_t own = w->tile.facet_count, rest = w->rest.facet_count;
    pbwt_bytes *facets = &w->matched;
    pbwt_facet *all = (pbwt_facet *)pbwm__take(g, (own + rest) * sizeof *all);
    pbw_status status = pbwm__agree(g, all != NULL ? PBW_OK : PBW_ERROR_MEMORY, "room for facets");
    if (all != NULL && own > 0) {
        memcpy(all, w->tile.facets, own * sizeof *all);
    }
    if (all != NULL && rest > 0) {
        memcpy(all + own, w->rest.facets, rest * sizeof *all);
    }
    facets->data = (char *)all;
    facets->size = (own + rest) * sizeof *all;
    status = status == PBW_OK ? pbwm__send_facets(w, facets, 0) : status;
    if (status == PBW_OK) {
        w->hull = pbwt_match((pbwt_facet *)(void *)facets->data, facets->size / sizeof *all);
        status = pbwm__send_facets(w, facets, 1);
    }
    if (status == PBW_OK) {
        qsort(facets->data, facets->size / sizeof *all, sizeof *all, pbwm__compare_facets);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>output       Chunks at their places in one file.
   In: chunks in files of their own.  Out: the output, in which each rank writes its chunk; rank 0 the header, last.
   ------------------------------------------------------------------------------------------------------ */
/* Fills `across` of a finished chunk with those facets that are of this tile.  Returns 0 if it cannot be written. */
static int pbwm__link_chunk(pbwm__work *w, pbwm__chunk *c, int number)
{
    const pbwt_facet *facet = (const pbwt_facet *)(const void *)w->matched.data;
    const size_t count = w->matched.size / sizeof *facet;
    size_t i;
    int good = pbwtf_seek(c->file, pbwtf_across_offset(&c->writer.chunk));
    for (i = 0; i < count && good; i++) {
        if (facet[i].from >> 40 == (uint64_t)number) {
            good = fwrite(&facet[i].to, 8, 1, c->file) == 1;
            c->entry.across_checksum = pbwtf_checksum(c->entry.across_checksum, &facet[i].to, 8);
        }
    }
    c->entry.size = pbwtf_chunk_size(&c->writer.chunk);
    c->entry.first_simplex = c->writer.chunk.simplices;
    return good && fflush(c->file) == 0;
}

/* Copies bytes from file to file, and adds them to a checksum. */
static int pbwm__copy(FILE *from, FILE *to, uint64_t size, uint64_t *sum)
{
    char block[65536];
    int good = 1;
    while (size > 0 && good) {
        const size_t some = size < sizeof block ? (size_t)size : sizeof block;
        good = fread(block, 1, some, from) == some && fwrite(block, 1, some, to) == some;
        *sum = good ? pbwtf_checksum(*sum, block, some) : 0;
        size -= some;
    }
    return good;
}

/* Copies a chunk to its place in the output, if it is what was written. */
static int pbwm__copy_chunk(pbwm__chunk *c, const char *path)
{
    const pbwtf_chunk *head = &c->writer.chunk;
    const uint64_t across = pbwtf_across_offset(head);
    uint64_t sum[3] = { 0, 0, 0 };
    FILE *file = fopen(path, "rb+");
    int good = file != NULL && pbwtf_seek(file, c->entry.offset) && pbwtf_seek(c->file, 0)
            && pbwm__copy(c->file, file, sizeof *head, sum)
            && pbwm__copy(c->file, file, across - sizeof *head, sum + 1)
            && pbwm__copy(c->file, file, c->entry.size - across, sum + 2);
    good = (file == NULL || fclose(file) == 0) && good;
    if (good && (sum[0] != pbwtf_checksum(0, head, sizeof *head) || sum[1] != head->checksum
                 || sum[2] != c->entry.across_checksum)) {
        errno = EIO;
        good = 0;
    }
    return good;
}

/* Gives each chunk its place; the header and the table, of rank 0. */
static int pbwm__write_head(pbwm__work *w, pbwtf_entry *table, pbwtf_header *header, const pbw_hash_sums *sums)
{
    uint64_t simplices = 0, at = sizeof *header;
    uint32_t p;
    FILE *file;
    int good;
    for (p = 0; p < header->chunks; p++) {
        const uint64_t count = table[p].first_simplex;
        table[p].first_simplex = simplices;
        table[p].offset = at;
        simplices += count;
        at += table[p].size;
    }
    header->table = at;
    header->size = at + header->chunks * sizeof *table;
    pbwtf_seal(header, sums);
    if (w->g->rank != 0) {
        return 1;
    }
    file = pbwtf_create(w->g->options.output, w->part, sizeof w->part);
    w->is_made = file != NULL;
    good = file != NULL && fwrite(header, sizeof *header, 1, file) == 1 && pbwtf_seek(file, at)
        && fwrite(table, sizeof *table, header->chunks, file) == header->chunks;
    return (file == NULL || fclose(file) == 0) && good;
}

static pbw_status pbwm__write(pbwm__work *w, pbwtf_header *header, const pbw_hash_sums *sums)
{
    pbwm__group *g = w->g;
    pbwtf_entry *table = (pbwtf_entry *)pbwm__take(g, ((size_t)g->ranks + 1) * sizeof *table);
    pbw_status status = pbwm__agree(g, table != NULL ? PBW_OK : PBW_ERROR_MEMORY, "room for the table of chunks");
    int good;
    if (status == PBW_OK) {
        MPI_Allgather(&w->chunk.entry, 4, g->word, table, 4, g->word, g->comm);
        table[g->ranks] = w->leftover.entry;
        MPI_Bcast(table + g->ranks, 4, g->word, 0, g->comm);
        header->chunks = (uint32_t)g->ranks + (table[g->ranks].size > 0);
        errno = 0;
        good = pbwm__write_head(w, table, header, sums);
        status = pbwm__agree_file(g, good, w->part);
        MPI_Bcast(w->part, (int)sizeof w->part, MPI_CHAR, 0, g->comm);
    }
    if (status == PBW_OK) {
        w->chunk.entry = table[g->rank];
        good = pbwm__copy_chunk(&w->chunk, w->part);
        if (g->rank == 0 && table[g->ranks].size > 0) {
            w->leftover.entry = table[g->ranks];
            good = pbwm__copy_chunk(&w->leftover, w->part) && good;
        }
        status = pbwm__agree_file(g, good, w->part);
    }
    if (status == PBW_OK) {
        status = pbwm__agree_file(g, g->rank != 0 || rename(w->part, g->options.output) == 0, g->options.output);
    }
    if (status != PBW_OK && w->is_made) {
        remove(w->part);
    }
    pbwm__give(g, table);
    return status;
}

static pbw_status pbwm__end_file(pbwm__work *w)
{
    pbwm__group *g = w->g;
    pbw_status status = pbwm__match(w);
    int good = 1;
    if (status == PBW_OK) {
        good = pbwm__link_chunk(w, &w->chunk, g->rank);
        if (g->rank == 0 && w->rest.memory != NULL) {
            good = pbwtf_end(&w->leftover.writer, &w->rest, g->dim) && pbwm__link_chunk(w, &w->leftover, g->ranks)
                && good;
        }
        status = pbwm__agree_file(g, good, w->chunk.name);
    }
    pbwm__end_phase(g, PBWM_LINKS);
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>triangulate  The stages in order.
   In: points, options.  Out: a tile on each rank, the output, the report.
   Holds: each stage ends with an agreement.
   ------------------------------------------------------------------------------------------------------ */
static uint64_t pbwm__resident(void)                 /* at most so far, in bytes */
{
    struct rusage usage;
    memset(&usage, 0, sizeof usage);
    getrusage(RUSAGE_SELF, &usage);
#ifdef __APPLE__
    return (uint64_t)usage.ru_maxrss;
#else
    return (uint64_t)usage.ru_maxrss * 1024;
#endif
}

static pbw_status pbwm__finish(pbwm__work *w)
{
    pbwm__group *g = w->g;
    pbwm_report *r = g->report;
    const pbwt_numbers *n = &w->tile.numbers, *rest = &w->rest.numbers;
    const uint64_t most[3] = { n->rounds, w->tree.count, pbwm__resident() };
    uint64_t sum[10], all[10], largest[3];
    pbwtf_header header;
    pbw_hash_sums sums;
    pbw_status status = PBW_OK;
    sum[0] = w->given;
    sum[1] = w->tree.duplicates;
    sum[2] = n->simplices + rest->simplices;
    sum[3] = g->options.output != NULL ? w->hull + n->hull + rest->hull : 0;
    sum[4] = n->halo + n->later;
    sum[5] = n->sent_bytes;
    sum[6] = w->tile.leftover_count;
    sum[7] = w->tile.hash.points + w->rest.hash.points;
    sum[8] = w->tile.hash.simplices + w->rest.hash.simplices;
    sum[9] = (uint64_t)w->resumed;
    MPI_Allreduce(sum, all, 10, MPI_UINT64_T, MPI_SUM, g->comm);
    MPI_Allreduce(most, largest, 3, MPI_UINT64_T, MPI_MAX, g->comm);
    MPI_Allreduce(&w->busy, r->busy, 1, MPI_DOUBLE, MPI_MIN, g->comm);
    MPI_Allreduce(&w->busy, r->busy + 1, 1, MPI_DOUBLE, MPI_SUM, g->comm);
    MPI_Allreduce(&w->busy, r->busy + 2, 1, MPI_DOUBLE, MPI_MAX, g->comm);
    r->busy[1] /= g->ranks;
    memset(&header, 0, sizeof header);
    header.dim = (uint32_t)g->dim;
    header.flags = pbwm__flags(g);
    header.tiles = header.chunks = (uint32_t)g->ranks;
    header.points = r->points = all[0];
    header.duplicates = r->duplicates = all[1];
    header.simplices = r->simplices = all[2];
    header.hull = r->hull = all[3];
    r->halo = all[4];
    r->sent_bytes = all[5];
    r->given_up = all[6];
    r->rounds = largest[0];
    r->largest = largest[1];
    r->memory = largest[2];
    r->resumed = all[9];
    sums.points = all[7];
    sums.simplices = all[8];
    pbwtf_seal(&header, &sums);
    r->hash = header.hash;
    status = g->options.output != NULL ? pbwm__write(w, &header, &sums) : PBW_OK;
    pbwm__end_phase(g, PBWM_WRITE);
    return status;
}

static pbw_status pbwm__run(pbwm__work *w, const pbwt_point *points, size_t count)
{
    pbwm__group *g = w->g;
    pbw_status status = pbwm__partition(w, points, count);
    w->given = count;
    w->tile_options.build = g->options.build;
    w->tile_options.halo = g->options.halo;
    w->tile_options.weighted = g->options.weighted;
    w->tile_options.no_links = g->options.output == NULL && g->options.emit == NULL;
    w->tile_options.emit = g->options.emit;
    w->tile_options.emit_user = g->options.emit_user;
    status = status == PBW_OK ? pbwm__plant(w) : status;
    status = status == PBW_OK && g->options.output != NULL ? pbwm__open_files(w) : status;
    status = status == PBW_OK ? pbwm__make_tile(w) : status;
    status = status == PBW_OK ? pbwm__leftovers(w) : status;
    status = status == PBW_OK && g->options.output != NULL ? pbwm__end_file(w) : status;
    status = status == PBW_OK ? pbwm__finish(w) : status;
    pbwm__leave(w, status);
    pbwt_close(&w->tile);
    pbwt_close(&w->rest);
    pbwt_tree_free(&w->tree);
    pbwm__give(g, w->mine.data);
    pbwm__give(g, w->matched.data);
    pbwm__give(g, w->kept);
    return status;
}

/* The cores of this node for each of its ranks. */
static int pbwm__threads(MPI_Comm comm)
{
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    MPI_Comm node;
    int ranks, threads;
    MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    MPI_Comm_size(node, &ranks);
    MPI_Comm_free(&node);
    threads = (int)(cores > 0 ? cores : 1) / ranks;
    return threads < 1 ? 1 : threads > 256 ? 256 : threads;
}

PBWDEF pbw_status pbwm_triangulate(MPI_Comm comm, const pbwt_point *points, size_t count,
                                   const pbwm_options *options, pbwm_report *report)
{
    pbwm__group g;
    pbwm__work w;
    pbw_status status;
    double longest[PBWM_PHASES];
    size_t ranks;
    memset(&g, 0, sizeof g);
    memset(&w, 0, sizeof w);
    memset(report, 0, sizeof *report);
    w.lock = -1;
    g.comm = comm;
    g.options = *options;
    pbw_memory_start(&g.memory, &options->build);
    g.memory.limit = 0;
    g.report = report;
    g.dim = options->dim == 2 ? 2 : 3;
    MPI_Comm_rank(comm, &g.rank);
    MPI_Comm_size(comm, &g.ranks);
    MPI_Type_contiguous(8, MPI_BYTE, &g.word);
    MPI_Type_commit(&g.word);
    if (g.options.build.threads == 0) {
        g.options.build.threads = pbwm__threads(comm);
    }
    ranks = (size_t)g.ranks;
    g.count = (int *)pbwm__take(&g, 2 * ranks * sizeof *g.count);
    g.request = (MPI_Request *)pbwm__take(&g, 2 * ranks * sizeof *g.request);
    w.g = &g;
    w.message = (pbwt_bytes *)pbwm__take(&g, 4 * (ranks + 1) * sizeof *w.message);
    w.served = (pbwt_served *)pbwm__take(&g, ranks * sizeof *w.served);
    w.summary = (pbwt_summary *)pbwm__take(&g, ranks * sizeof *w.summary);
    g.began = MPI_Wtime();
    status = g.count != NULL && g.request != NULL && w.message != NULL && w.served != NULL && w.summary != NULL
           ? PBW_OK : PBW_ERROR_MEMORY;
    status = pbwm__agree(&g, status, "room for lists of ranks");
    status = status == PBW_OK ? pbwm__run(&w, points, count) : status;
    if (g.options.taken != NULL) {
        g.options.taken(g.options.taken_user);
    }
    MPI_Allreduce(report->seconds, longest, PBWM_PHASES, MPI_DOUBLE, MPI_MAX, comm);
    memcpy(report->seconds, longest, sizeof longest);
    pbwm__give(&g, g.count);
    pbwm__give(&g, g.request);
    pbwm__give(&g, w.message);
    pbwm__give(&g, w.served);
    pbwm__give(&g, w.summary);
    MPI_Type_free(&g.word);
    return status;
}

#endif /* PBW_MPI_IMPLEMENTATION */
