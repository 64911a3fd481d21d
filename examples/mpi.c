/* mpi.c: one triangulation by many machines, over MPI: each rank reads a slice of the points, gets those of its part,
   and has its tile of the triangulation in the end; together they are that of pbw_triangulate: see the hash.
   mpicc -O2 -I. -Iexamples/lib examples/mpi.c -o mpi -lpthread -lm
   mpirun -np 8 ./mpi points.bin [--dim 2] [--weights w] [--threads 2] [--memory-limit BYTES] [-o mesh.pbwt]
   mpirun -np 8 ./mpi --generate 1000000                         a million uniform points for each rank
   points.bin: doubles x y (z) (weight).  mesh.pbwt: see pbw_tilefile.h. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_TILES_IMPLEMENTATION
#include "pbw_tiles.h"
#define PBW_TILEFILE_IMPLEMENTATION
#include "pbw_tilefile.h"
#include <float.h>
#include <mpi.h>
#include <signal.h>

enum { READ, PARTITION, TILE, LEFTOVERS, LINKS, WRITE, PHASES };

static int rank, ranks, weighted, dim = 3;           /* a program's own: the headers have none */
static double phase[PHASES], began;
static MPI_Datatype word;                            /* 8 bytes: counts of more than 2^31 bytes fit an int */
static char text[1200];                               /* why this rank failed */

/* All ranks call this; if one failed, that of the lowest number says why, and all end. */
static void agree(int failed, const char *what)
{
    int lowest = failed ? rank : ranks, least;
    MPI_Allreduce(&lowest, &least, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (least < ranks) {
        if (rank == least) {
            fprintf(stderr, "mpi: rank %d: %s%s%s\n", rank, what, *text != 0 ? ": " : "", text);
        }
        MPI_Finalize();
        exit(1);
    }
}

static void end_phase(int which)
{
    const double now = MPI_Wtime();
    phase[which] += now - began;
    began = now;
}

static void *take(size_t bytes)
{
    void *block = malloc(bytes + 1);
    if (block == NULL) {
        fprintf(stderr, "mpi: rank %d: out of memory: %zu bytes\n", rank, bytes);
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    return block;
}

/* Sends out[p], whole words, to each rank p.  in[p]: what came from it, in one block that in[0].data begins. */
static void exchange(const pbwt_bytes *out, pbwt_bytes *in)
{
    int *count = (int *)take(4 * (size_t)ranks * sizeof(int)), *from = count + ranks, *get = from + ranks;
    int *to = get + ranks, p;
    size_t all = 0, sum = 0;
    char *send, *receive;
    for (p = 0; p < ranks; p++) {
        count[p] = (int)(out[p].size / 8);
        from[p] = (int)(all / 8);
        all += out[p].size;
    }
    send = (char *)take(all);
    MPI_Alltoall(count, 1, MPI_INT, get, 1, MPI_INT, MPI_COMM_WORLD);
    for (p = 0; p < ranks; p++) {
        if (out[p].size > 0) {
            memcpy(send + 8 * (size_t)from[p], out[p].data, out[p].size);
        }
        to[p] = (int)sum;
        sum += (size_t)get[p];
    }
    agree(sum > 0x7fffffff || all / 8 > 0x7fffffff, "more than 16 GB in one exchange: more ranks are needed");
    receive = (char *)take(8 * sum);
    MPI_Alltoallv(send, count, from, word, receive, get, to, word, MPI_COMM_WORLD);
    for (p = 0; p < ranks; p++) {
        in[p].data = receive + 8 * (size_t)to[p];
        in[p].size = 8 * (size_t)get[p];
    }
    free(send);
    free(count);
}

/* Sorts records into one string for each rank, of an exchange; to[i]: of record i.  Free out[0].data. */
static void sort_out(const void *records, size_t count, size_t size, const int *to, pbwt_bytes *out)
{
    char *block = (char *)take(count * size);
    size_t i;
    int p;
    memset(out, 0, (size_t)ranks * sizeof *out);
    for (i = 0; i < count; i++) {
        out[to[i]].size += size;
    }
    for (p = 0; p < ranks; p++) {
        out[p].data = p > 0 ? out[p - 1].data + out[p - 1].size : block;
    }
    for (p = 0; p < ranks; p++) {
        out[p].size = 0;
    }
    for (i = 0; i < count; i++) {
        pbwt_bytes *o = out + to[i];
        memcpy(o->data + o->size, (const char *)records + i * size, size);
        o->size += size;
    }
}

static uint64_t mixed(uint64_t x)                    /* splitmix64 (Steele, Lea and Flood 2014) */
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

/* ---- the points of this rank's slice, then those of its part */

static pbwt_point *read_slice(const char *path, size_t generate, size_t *count, uint64_t *all)
{
    const size_t each = (size_t)(dim + weighted);
    FILE *file = path != NULL ? fopen(path, "rb") : NULL;
    long size = file != NULL && fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    uint64_t first, i;
    pbwt_point *points;
    double row[4] = { 0, 0, 0, 0 };
    int k, bad = 0;
    *all = path == NULL ? (uint64_t)generate * (uint64_t)ranks : size >= 0 ? (uint64_t)size / (each * 8) : 0;
    snprintf(text, sizeof text, "%s", path != NULL ? path : "");
    agree(path != NULL && size < 0, "cannot read");
    agree(path != NULL && (uint64_t)size % (each * 8) != 0, "truncated: no whole number of points");
    first = *all * (uint64_t)rank / (uint64_t)ranks;
    *count = (size_t)(*all * (uint64_t)(rank + 1) / (uint64_t)ranks - first);
    points = (pbwt_point *)take(*count * sizeof *points);
    bad = file != NULL && fseek(file, (long)(first * each * 8), SEEK_SET) != 0;
    for (i = 0; i < *count && !bad; i++) {
        memset(points + i, 0, sizeof *points);
        for (k = 0; file == NULL && k < dim; k++) {
            row[k] = (double)(mixed((first + i) * 3 + (uint64_t)k) >> 11) / 9007199254740992.0;
        }
        bad = file != NULL && fread(row, sizeof *row, each, file) != each;
        for (k = 0; k < (int)each && !bad; k++) {
            bad = row[k] >= -DBL_MAX && row[k] <= DBL_MAX ? 0 : 2;
        }
        snprintf(text, bad ? sizeof text : 0, "%s, point %llu", path, (unsigned long long)(first + i));
        memcpy(points[i].x, row, (size_t)dim * sizeof *row);
        points[i].weight = weighted ? row[dim] : 0;
        points[i].id = first + i;
    }
    agree(bad == 1, "cannot read, or truncated");
    agree(bad == 2, "a number is not finite");
    *text = 0;
    if (file != NULL) {
        fclose(file);
    }
    return points;
}

static pbwt_point *partition(pbwt_point *mine, size_t *count)
{
    const int each = ranks > 256 ? 256 : 4096;
    pbwt_point *sample = (pbwt_point *)take((size_t)each * (size_t)ranks * sizeof *sample);
    pbwt_point *some = (pbwt_point *)take((size_t)each * sizeof *some);
    pbwt_cut *cuts = (pbwt_cut *)take((size_t)ranks * sizeof *cuts);
    pbwt_bytes *out = (pbwt_bytes *)take(2 * (size_t)ranks * sizeof *out), *in = out + ranks;
    int *to = (int *)take(*count * sizeof *to), *had = (int *)take(2 * (size_t)ranks * sizeof *had);
    int n = *count < (size_t)each ? (int)*count : each, p, words = n * (int)(sizeof *some / 8), all = 0;
    size_t i;
    for (p = 0; p < n; p++) {
        some[p] = mine[mixed((uint64_t)p) % *count];
    }
    MPI_Allgather(&words, 1, MPI_INT, had, 1, MPI_INT, MPI_COMM_WORLD);
    for (p = 0; p < ranks; p++) {
        had[ranks + p] = all;
        all += had[p];
    }
    MPI_Allgatherv(some, words, word, sample, had, had + ranks, word, MPI_COMM_WORLD);
    pbwt_cut_points(dim, sample, (size_t)all / (sizeof *some / 8), ranks, cuts);
    for (i = 0; i < *count; i++) {
        to[i] = pbwt_part(dim, cuts, ranks, mine + i);
    }
    sort_out(mine, *count, sizeof *mine, to, out);
    free(mine);
    exchange(out, in);
    for (p = 0, i = 0; p < ranks; p++) {
        i += in[p].size;
    }
    *count = i / sizeof *mine;
    mine = (pbwt_point *)(void *)in[0].data;
    free(out[0].data);
    free(out);
    free(sample);
    free(some);
    free(cuts);
    free(to);
    free(had);
    return mine;
}

/* ---- the tile */

static void run_tile(pbwt_tile *tile, const pbwt_tree *tree, const pbwt_summary *summary)
{
    pbwt_served *served = (pbwt_served *)calloc((size_t)ranks, sizeof *served);
    pbwt_bytes *asked = (pbwt_bytes *)calloc(3 * (size_t)ranks, sizeof *asked);
    pbwt_bytes *reply = asked + ranks, *got = reply + ranks;
    pbw_status status;
    int more, any, p;
    for (;;) {
        status = pbwt_ask(tile, &more);
        snprintf(text, sizeof text, "%s: %zu points, %zu of others", pbw_status_string(status), tree->count,
                 tile->foreign_count);
        agree(status != PBW_OK, "tile");
        MPI_Allreduce(&more, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
        if (!any) {
            break;
        }
        exchange(tile->request, asked);
        for (p = 0; p < ranks && status == PBW_OK; p++) {
            if (asked[p].size > 0) {
                status = pbwt_answer(tree, served + p, asked + p, NULL, summary[p].count, reply + p);
            }
        }
        agree(status != PBW_OK, pbw_status_string(status));
        free(asked[0].data);
        exchange(reply, got);
        for (p = 0; p < ranks && status == PBW_OK; p++) {
            if (got[p].size > 0) {
                status = pbwt_take(tile, p, got[p].data, got[p].size);
            }
            pbwt_bytes_free(tree, reply + p);
        }
        agree(status != PBW_OK, pbw_status_string(status));
        free(got[0].data);
    }
    *text = 0;
    for (p = 0; p < ranks; p++) {
        pbwt_served_free(tree, served + p);
    }
    free(served);
    free(asked);
}

static int compare_ids(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

/* Gives a string of this rank to all others (root < 0) or to one; returns them joined; *size: of it. */
static char *join(const pbwt_bytes *mine, int root, size_t *size)
{
    pbwt_bytes *out = (pbwt_bytes *)calloc(2 * (size_t)ranks, sizeof *out), *in = out + ranks;
    char *all;
    int p;
    for (p = 0; p < ranks; p++) {
        out[p] = *mine;
        out[p].size = root < 0 || p == root ? mine->size : 0;
    }
    exchange(out, in);
    for (p = 0, *size = 0; p < ranks; p++) {
        *size += in[p].size;
    }
    all = in[0].data;
    free(out);
    return all;
}

/* Triangulates what all ranks gave up, on rank 0. */
static void finish(pbwt_tile *rest, const pbwt_tile *tile, const pbwt_tree *tree, const pbwt_options *options)
{
    pbwt_bytes mine, known;
    uint64_t *ids = (uint64_t *)take(tile->leftover_count * sizeof *ids);
    pbw_status status;
    size_t i, size;
    for (i = 0; i < tile->leftover_count; i++) {
        ids[i] = tree->points[tile->leftovers[i]].id;
    }
    mine.data = (char *)ids;
    mine.size = tile->leftover_count * sizeof *ids;
    known.data = join(&mine, -1, &size);
    free(ids);
    if (size > 0) {
        qsort(known.data, size / 8, 8, compare_ids);
        status = pbwt_leftovers(tile, (uint64_t *)(void *)known.data, size / 8, &mine);
        agree(status != PBW_OK, pbw_status_string(status));
        free(known.data);
        known.data = join(&mine, 0, &known.size);
        pbwt_bytes_free(tree, &mine);
        status = rank == 0 ? pbwt_finish(rest, dim, ranks, &known, options) : PBW_OK;
        snprintf(text, sizeof text, "%zu points were given up: %s", size / 8, pbw_status_string(status));
        agree(status != PBW_OK, "leftovers");
        *text = 0;
    }
    free(known.data);
}

static int compare_facets(const void *a, const void *b)              /* the order in which a tile has them */
{
    const uint64_t x = ((const pbwt_facet *)a)->from, y = ((const pbwt_facet *)b)->from;
    return x < y ? -1 : x > y;
}

/* ---- links across tiles: facets meet at the rank that their lowest id names, and go back */

static size_t match(const pbwt_facet *facets, size_t count, pbwt_facet **matched, uint64_t *hull)
{
    int *to = (int *)take(count * sizeof *to);
    pbwt_bytes *out = (pbwt_bytes *)take(2 * (size_t)ranks * sizeof *out), *in = out + ranks;
    size_t i, size = 0;
    int p;
    for (i = 0; i < count; i++) {
        to[i] = (int)(mixed(facets[i].id[0]) % (uint64_t)ranks);
    }
    sort_out(facets, count, sizeof *facets, to, out);
    free(to);
    exchange(out, in);
    free(out[0].data);
    for (p = 0; p < ranks; p++) {
        size += in[p].size / sizeof *facets;
    }
    *hull = pbwt_match((pbwt_facet *)(void *)in[0].data, size);
    to = (int *)take(size * sizeof *to);
    for (i = 0; i < size; i++) {                     /* leftovers, tile `ranks`, are on rank 0 */
        to[i] = (int)((((const pbwt_facet *)(void *)in[0].data)[i].from >> 40) % (uint64_t)ranks);
    }
    facets = (const pbwt_facet *)(void *)in[0].data;
    sort_out(facets, size, sizeof *facets, to, out);
    free(in[0].data);
    exchange(out, in);
    for (p = 0, size = 0; p < ranks; p++) {
        size += in[p].size / sizeof *facets;
    }
    *matched = (pbwt_facet *)(void *)in[0].data;
    qsort(*matched, size, sizeof **matched, compare_facets);
    free(out[0].data);
    free(out);
    free(to);
    return size;
}

/* ---- the file: each rank has its chunk in a file of its own, and copies it to its place */

typedef struct part {
    pbwtf_writer writer;
    pbwtf_entry entry;
    char name[1100];
    FILE *file;
} part;

static void open_part(part *c, const char *path, int number)
{
    memset(c, 0, sizeof *c);
    if (path != NULL) {
        snprintf(c->name, sizeof c->name, "%s.%d", path, number);
        c->file = fopen(c->name, "wb+");
    }
    snprintf(text, sizeof text, "%s", c->name);
    agree(path != NULL && c->file == NULL, "cannot write");
    *text = 0;
}

/* Fills `across` of a finished chunk with those facets that are of this tile. */
static void link_part(part *c, const pbwt_facet *facets, size_t count, uint64_t tile)
{
    size_t i;
    int bad = c->file != NULL && fseek(c->file, (long)pbwtf_across_offset(&c->writer.chunk), SEEK_SET) != 0;
    for (i = 0; i < count && c->file != NULL; i++) {
        if (facets[i].from >> 40 == tile) {
            bad |= fwrite(&facets[i].to, 8, 1, c->file) != 1;
            c->entry.across_checksum = pbwtf_checksum(c->entry.across_checksum, &facets[i].to, 8);
        }
    }
    c->entry.size = c->file != NULL ? pbwtf_chunk_size(&c->writer.chunk) : 0;
    c->entry.first_simplex = c->writer.chunk.simplices;
    bad |= c->file != NULL && fflush(c->file) != 0;
    snprintf(text, sizeof text, "%s", c->name);
    agree(bad, "cannot write; is the disk full?");
    *text = 0;
}

static void copy_part(part *c, const char *path)
{
    char *block = (char *)take(1 << 20);
    FILE *file = fopen(path, "rb+");
    size_t left = (size_t)c->entry.size;
    int bad = file == NULL || fseek(file, (long)c->entry.offset, SEEK_SET) != 0;
    bad |= c->file != NULL && fseek(c->file, 0, SEEK_SET) != 0;
    left = c->file != NULL ? left : 0;               /* leftovers are on rank 0 only */
    while (left > 0 && !bad) {
        const size_t size = left < 1 << 20 ? left : 1 << 20;
        bad = fread(block, 1, size, c->file) != size || fwrite(block, 1, size, file) != size;
        left -= size;
    }
    bad |= file != NULL && fclose(file) != 0;
    if (c->file != NULL) {
        fclose(c->file);
        remove(c->name);
    }
    free(block);
    snprintf(text, sizeof text, "%s", path);
    agree(bad, "cannot write; is the disk full?");
    *text = 0;
}

/* Header and table; chunks: of all ranks, then that of the leftovers, if there are. */
static void write_file(const char *path, part *mine, part *rest, pbwtf_header *header, const pbw_hash_sums *sums)
{
    pbwtf_entry *table = (pbwtf_entry *)take(((size_t)ranks + 1) * sizeof *table);
    uint64_t simplices = 0, at = sizeof *header;
    FILE *file = NULL;
    int p;
    MPI_Allgather(&mine->entry, 4, word, table, 4, word, MPI_COMM_WORLD);
    table[ranks] = rest->entry;
    MPI_Bcast(table + ranks, 4, word, 0, MPI_COMM_WORLD);
    header->chunks = (uint32_t)ranks + (table[ranks].size > 0);
    for (p = 0; p < (int)header->chunks; p++) {
        const uint64_t count = table[p].first_simplex;
        table[p].first_simplex = simplices;
        table[p].offset = at;
        simplices += count;
        at += table[p].size;
    }
    header->table = at;
    header->size = at + header->chunks * sizeof *table;
    pbwtf_seal(header, sums);
    if (rank == 0) {
        file = fopen(path, "wb");
    }
    p = rank == 0 && (file == NULL || fwrite(header, sizeof *header, 1, file) != 1
                      || fseek(file, (long)at, SEEK_SET) != 0
                      || fwrite(table, sizeof *table, header->chunks, file) != header->chunks || fclose(file) != 0);
    snprintf(text, sizeof text, "%s", path);
    agree(p, "cannot write");
    mine->entry = table[rank];
    rest->entry = table[ranks];
    copy_part(mine, path);
    if (rest->entry.size > 0) {
        copy_part(rest, path);
    }
    free(table);
}

/* ---- what came out */

static void report(const pbwtf_header *header, const pbwt_tile *tile, const pbwt_tree *tree, uint64_t given)
{
    const pbwt_numbers *n = &tile->numbers;
    uint64_t sum[3], all[3], most[2], largest[2];
    double longest[PHASES];
    sum[0] = n->halo + n->later;
    sum[1] = n->sent_bytes;
    sum[2] = tree->count;
    most[0] = n->rounds;
    most[1] = tree->count;
    MPI_Reduce(sum, all, 3, MPI_UINT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
    MPI_Reduce(most, largest, 2, MPI_UINT64_T, MPI_MAX, 0, MPI_COMM_WORLD);
    MPI_Reduce(phase, longest, PHASES, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
    if (rank == 0) {
        const double points = (double)(all[2] > 0 ? all[2] : 1);
        printf("%d ranks: %.0f points, %.0f simplices, hash %016llx, halo %.1f %%, %.0f rounds, %.1f bytes a point, "
               "imbalance %.3f, %.0f given up; seconds: read %.2f, partition %.2f, tiles %.2f, leftovers %.2f, "
               "links %.2f, write %.2f\n", ranks, (double)header->points, (double)header->simplices,
               (unsigned long long)header->hash, 100 * (double)all[0] / points, (double)largest[0],
               (double)all[1] / points, (double)largest[1] * ranks / points, (double)given, longest[READ],
               longest[PARTITION], longest[TILE], longest[LEFTOVERS], longest[LINKS], longest[WRITE]);
    }
}

static const char *argument(int argc, char **argv, const char *name)
{
    int i;
    for (i = 1; i + 1 < argc; i++) {
        if (strcmp(argv[i], name) == 0) {
            return argv[i + 1];
        }
    }
    return NULL;
}

static size_t number(int argc, char **argv, const char *name)
{
    const char *value = argument(argc, argv, name);
    return value != NULL ? (size_t)strtoull(value, NULL, 10) : 0;
}

/* All of one rank's work. */
typedef struct work {
    const char *output;
    uint64_t all;                                    /* points of all ranks */
    pbwt_summary *summary;
    pbwt_tree tree;
    pbwt_tile tile, rest;                            /* rest: leftovers, on rank 0 */
    part chunk, leftover;
    pbwt_options options;
} work;

static void make_tree(work *w, pbwt_point *points, size_t count)
{
    pbwt_summary mine;
    pbw_status status = pbwt_tree_make(dim, rank, points, count, &w->options.build, &w->tree);
    agree(status != PBW_OK, pbw_status_string(status));
    free(points);
    w->summary = (pbwt_summary *)take((size_t)ranks * sizeof *w->summary);
    pbwt_summarise(&w->tree, &mine);
    MPI_Allgather(&mine, (int)(sizeof mine / 8), word, w->summary, (int)(sizeof mine / 8), word, MPI_COMM_WORLD);
    end_phase(PARTITION);
}

static void make_tile(work *w)
{
    const uint32_t flags = (weighted ? PBWTF_WEIGHTS : 0) | PBWTF_LINKS;
    pbw_status status;
    int bad = 0;
    open_part(&w->chunk, w->output, rank);
    open_part(&w->leftover, rank == 0 ? w->output : NULL, ranks);
    w->options.weighted = weighted;
    w->options.no_links = w->output == NULL;
    w->options.emit = w->output != NULL ? pbwtf_emit : NULL;
    w->options.emit_user = &w->chunk.writer;
    if (w->output != NULL) {
        pbwtf_begin(&w->chunk.writer, w->chunk.file, &w->tree, (uint32_t)rank, flags);
    }
    status = pbwt_open(&w->tile, &w->tree, w->summary, ranks, &w->options);
    agree(status != PBW_OK, pbw_status_string(status));
    run_tile(&w->tile, &w->tree, w->summary);
    end_phase(TILE);
    w->options.emit_user = &w->leftover.writer;
    if (w->leftover.file != NULL) {
        pbwtf_begin(&w->leftover.writer, w->leftover.file, NULL, (uint32_t)ranks, flags);
    }
    finish(&w->rest, &w->tile, &w->tree, &w->options);
    if (w->output != NULL) {
        bad = !pbwtf_end(&w->chunk.writer, &w->tile, dim);
        bad |= w->rest.memory != NULL && w->leftover.file != NULL && !pbwtf_end(&w->leftover.writer, &w->rest, dim);
    }
    agree(bad, "cannot write; is the disk full?");
    end_phase(LEFTOVERS);
}

/* Returns the facets of the hull that this rank matched. */
static uint64_t link_tile(work *w)
{
    const size_t own = w->tile.facet_count, rest = w->rest.facet_count;
    pbwt_facet *facets = (pbwt_facet *)take((own + rest) * sizeof *facets), *matched;
    uint64_t hull;
    size_t count;
    if (own > 0) {
        memcpy(facets, w->tile.facets, own * sizeof *facets);
    }
    if (rest > 0) {
        memcpy(facets + own, w->rest.facets, rest * sizeof *facets);
    }
    count = match(facets, own + rest, &matched, &hull);
    free(facets);
    if (w->rest.memory == NULL && w->leftover.file != NULL) {
        fclose(w->leftover.file);
        remove(w->leftover.name);
        w->leftover.file = NULL;
    }
    link_part(&w->chunk, matched, count, (uint64_t)rank);
    link_part(&w->leftover, matched, count, (uint64_t)ranks);
    free(matched);
    return hull;
}

static void end_file(work *w, uint64_t hull)
{
    uint64_t sum[6], total[6];
    pbwtf_header header;
    pbw_hash_sums sums;
    sum[0] = hull + w->tile.numbers.hull + w->rest.numbers.hull;
    sum[1] = w->tile.hash.points + w->rest.hash.points;
    sum[2] = w->tile.hash.simplices + w->rest.hash.simplices;
    sum[3] = w->tile.numbers.simplices + w->rest.numbers.simplices;
    sum[4] = w->tree.duplicates;
    sum[5] = w->tile.leftover_count;
    MPI_Allreduce(sum, total, 6, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    end_phase(LINKS);
    memset(&header, 0, sizeof header);
    header.dim = (uint32_t)dim;
    header.flags = (weighted ? PBWTF_WEIGHTS : 0) | PBWTF_LINKS;
    header.tiles = header.chunks = (uint32_t)ranks;
    header.points = w->all;
    header.duplicates = total[4];
    header.simplices = total[3];
    header.hull = total[0];
    sums.points = total[1];
    sums.simplices = total[2];
    if (w->output != NULL) {
        write_file(w->output, &w->chunk, &w->leftover, &header, &sums);
    } else {
        pbwtf_seal(&header, &sums);
    }
    end_phase(WRITE);
    report(&header, &w->tile, &w->tree, total[5]);
}

int main(int argc, char **argv)
{
    const char *input = argc > 1 && argv[1][0] != '-' ? argv[1] : NULL, *output = argument(argc, argv, "-o");
    pbwt_point *points;
    size_t count;
    work w;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    MPI_Type_contiguous(8, MPI_BYTE, &word);
    MPI_Type_commit(&word);
    memset(&w, 0, sizeof w);
    w.output = output;
    w.options.build.threads = (int)number(argc, argv, "--threads");
    w.options.build.threads = w.options.build.threads > 0 ? w.options.build.threads : 1;
    w.options.build.memory_limit = number(argc, argv, "--memory-limit");
    dim = number(argc, argv, "--dim") == 2 ? 2 : 3;
    weighted = argument(argc, argv, "--weights") != NULL;
    agree(input == NULL && number(argc, argv, "--generate") == 0, "mpi points.bin, or mpi --generate N; see mpi.c");
    began = MPI_Wtime();
    points = read_slice(input, number(argc, argv, "--generate"), &count, &w.all);
    end_phase(READ);
    points = partition(points, &count);
    if (argument(argc, argv, "--die") != NULL && number(argc, argv, "--die") == (size_t)rank) {
        raise(SIGKILL);                              /* for a test: the others must end, too */
    }
    make_tree(&w, points, count);
    make_tile(&w);
    end_file(&w, w.output != NULL ? link_tile(&w) : 0);
    pbwt_close(&w.tile);
    pbwt_close(&w.rest);
    pbwt_tree_free(&w.tree);
    free(w.summary);
    MPI_Type_free(&word);
    MPI_Finalize();
    return 0;
}
