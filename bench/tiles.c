/* tiles.c: what a rank of many sends and receives, counted and not modelled: real points, real cuts, and the work of
   a few of the ranks, spread over all of them, with answers by the trees of the others.  If all ranks work, also
   their processor time beside that of one triangulation, one thread each, and whether the hashes agree.
   cc -O2 -I. -Iexamples/lib -Itests bench/tiles.c -o tiles -lpthread -lm
   ./tiles RANKS POINTS_A_RANK [KIND [OF]]    KIND: of tests/inputs.h, ellipsoid or torus; OF: how many work
   ./tiles inner POINTS       one rank, a cube of so many uniform points on average, with others on all sides: of
                              these, six, only points within 12 spacings of the cube are there */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_TILES_IMPLEMENTATION
#include "pbw_tiles.h"
#include "inputs.h"
#include <stdio.h>
#include <time.h>

enum { SLICES, SLICE_BYTES, PARTNERS, ASKED, MESSAGES, BYTES, HALO, LATER, ROUNDS, QUESTIONS, PATCH, LINKED,
       LINK_BYTES, MEMORY, COUNTS };
static const char *const names[COUNTS] = {
    "partition: messages", "partition: bytes", "partners", "partners with points", "messages", "bytes", "halo points",
    "points after the first questions", "rounds of questions", "questions", "points of repairs", "links: partners",
    "links: bytes, there and back", "memory at most, bytes" };
typedef struct count { double of[COUNTS]; } count;
typedef struct times { double tree, tile, answer; } times;           /* of all ranks, processor seconds */

static double clocked(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

static void *take(size_t bytes)
{
    void *block = calloc(bytes + 1, 1);
    if (block == NULL) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    return block;
}

static void need(pbw_status status)
{
    if (status != PBW_OK) {
        fprintf(stderr, "%s\n", pbw_status_string(status));
        exit(1);
    }
}

/* Surfaces that are no sphere: an ellipsoid of half axes 1, 0.7, 0.4, and a torus of radii 1, 0.3. */
enum { ELLIPSOID = INPUT_KINDS, TORUS, KINDS };

static const char *kind_name(int kind)
{
    return kind == ELLIPSOID ? "ellipsoid" : kind == TORUS ? "torus" : input_name(kind);
}

static int kind_of(const char *name)
{
    int kind = 0;
    while (kind < KINDS && strcmp(kind_name(kind), name) != 0) {
        kind++;
    }
    return kind;
}

static void fill(int kind, size_t n, double *x)
{
    size_t i;
    input_fill(kind < INPUT_KINDS ? kind : kind == TORUS ? INPUT_UNIFORM : INPUT_SPHERE, 3, n, 1, x);
    for (i = 0; i < n && kind >= INPUT_KINDS; i++) {
        double *p = x + 3 * i;
        const double u = INPUT_TURN * p[0], v = INPUT_TURN * p[1];
        p[0] = kind == TORUS ? (1 + 0.3 * cos(v)) * cos(u) : p[0];
        p[1] = kind == TORUS ? (1 + 0.3 * cos(v)) * sin(u) : 0.7 * p[1];
        p[2] = kind == TORUS ? 0.3 * sin(v) : 0.4 * p[2];
    }
}

typedef struct study {
    int ranks, kind, of;                             /* of: ranks that work */
    size_t each, n;                                  /* points of one, of all */
    double shell;                                    /* 0, or the width of the six ranks around rank 0, the unit cube */
    double *x;
    int *part;                                       /* per point */
    pbwt_tree *tree;
    pbwt_summary *summary;
    times spent;
    pbw_hash_sums sums;
    size_t used, peak;                               /* memory of the rank at work, and of answers to it; if all work, it
                                                        is not counted */
} study;

static void *metered(void *user, void *ptr, size_t old_size, size_t new_size)
{
    study *s = (study *)user;
    void *block = new_size > 0 ? realloc(ptr, new_size) : NULL;
    if (new_size == 0) {
        free(ptr);
    }
    if (new_size == 0 || block != NULL) {
        s->used += new_size - old_size;
        s->peak = s->used > s->peak ? s->used : s->peak;
    }
    return block;
}

/* The rank of a point of the cube or its shell: slabs across x, then y, then z. */
static int shell_part(const double *x)
{
    int k;
    for (k = 0; k < 3; k++) {
        if (x[k] < 0 || x[k] > 1) {
            return 1 + 2 * k + (x[k] > 1);
        }
    }
    return 0;
}

/* Cuts by 64 points a rank; returns the points by part, and where parts begin. */
static pbwt_point *partition(study *s, size_t *first)
{
    pbwt_point *all = (pbwt_point *)take(s->n * sizeof *all), *sorted = (pbwt_point *)take(s->n * sizeof *all);
    pbwt_point *sample = (pbwt_point *)take((size_t)s->ranks * 64 * sizeof *sample);
    pbwt_cut *cuts = (pbwt_cut *)take((size_t)s->ranks * sizeof *cuts);
    size_t *next = (size_t *)take(((size_t)s->ranks + 1) * sizeof *next), i, samples = 0;
    int p;
    for (i = 0; i < s->n; i++) {
        memcpy(all[i].x, s->x + 3 * i, sizeof all[i].x);
        all[i].id = i;
    }
    for (i = 0; i < s->n; i += 1 + s->n / ((size_t)s->ranks * 64)) {
        sample[samples++] = all[i];
    }
    pbwt_cut_points(3, sample, samples, s->ranks, cuts);
    for (i = 0; i < s->n; i++) {
        s->part[i] = s->shell > 0 ? shell_part(all[i].x) : pbwt_part(3, cuts, s->ranks, all + i);
        first[s->part[i] + 1]++;
    }
    for (p = 0; p < s->ranks; p++) {
        first[p + 1] += first[p];
        next[p] = first[p];
    }
    for (i = 0; i < s->n; i++) {
        sorted[next[s->part[i]]++] = all[i];
    }
    free(all);
    free(sample);
    free(cuts);
    free(next);
    return sorted;
}

/* A tree for each part; timed if all ranks work. */
static void plant(study *s)
{
    size_t *first = (size_t *)take(((size_t)s->ranks + 1) * sizeof *first);
    pbwt_point *sorted = partition(s, first);
    pbw_options serial;
    int p;
    memset(&serial, 0, sizeof serial);
    serial.threads = 1;
    if (s->of < s->ranks) {
        serial.resize = metered;
        serial.resize_user = s;
    }
    for (p = 0; p < s->ranks; p++) {
        const double start = clocked();
        need(pbwt_tree_make(3, p, sorted + first[p], first[p + 1] - first[p], &serial, s->tree + p));
        pbwt_summarise(s->tree + p, s->summary + p);
        s->spent.tree += clocked() - start;
    }
    free(sorted);
    free(first);
}

/* Points in the order of the input: a rank reads a slice of it, and sends them where they belong. */
static void count_slice(const study *s, int p, count *c)
{
    char *to = (char *)take((size_t)s->ranks);
    size_t i;
    for (i = s->each * (size_t)p; i < s->each * (size_t)(p + 1); i++) {
        if (s->part[i] != p) {
            c->of[SLICES] += to[s->part[i]] == 0;
            c->of[SLICE_BYTES] += sizeof(pbwt_point);
            to[s->part[i]] = 1;
        }
    }
    free(to);
}

/* Facets go to the owner of their vertex of the lowest id, and back. */
static void count_links(const study *s, const pbwt_tile *tile, int p, count *c)
{
    char *to = (char *)take((size_t)s->ranks);
    size_t i;
    for (i = 0; i < tile->facet_count; i++) {
        if (tile->facets[i].to != (uint64_t)p) {
            c->of[LINKED] += to[tile->facets[i].to] == 0;
            c->of[LINK_BYTES] += 2 * sizeof(pbwt_facet);
            to[tile->facets[i].to] = 1;
        }
    }
    free(to);
}

/* The messages of one rank's tile; the others answer. */
static void build(study *s, pbwt_tile *tile, int p, count *c)
{
    pbwt_served *served = (pbwt_served *)take((size_t)s->ranks * sizeof *served);
    pbwt_bytes reply = { NULL, 0 };
    int q, more = 1;
    while (need(pbwt_ask(tile, &more)), more) {
        for (q = 0; q < s->ranks; q++) {
            if (tile->request[q].size > 0) {
                const double asked = clocked();
                need(pbwt_answer(s->tree + q, served + q, tile->request + q, NULL, s->summary[p].count, &reply));
                s->spent.answer += clocked() - asked;
                need(pbwt_take(tile, q, reply.data, reply.size));
                c->of[MESSAGES] += 2;
                pbwt_bytes_free(s->tree + q, &reply);
            }
        }
    }
    for (q = 0; q < s->ranks; q++) {
        c->of[PARTNERS] += served[q].visits > 0;
        c->of[ASKED] += served[q].sent > 0;
        pbwt_served_free(s->tree + q, served + q);
    }
    free(served);
}

static count work(study *s, int p)
{
    const double start = clocked(), answered = s->spent.answer;
    pbwt_options options;
    pbwt_tile tile;
    count c;
    memset(&c, 0, sizeof c);
    memset(&options, 0, sizeof options);
    options.build.threads = 1;
    s->used = s->peak = s->tree[p].bytes;
    if (s->of < s->ranks) {
        options.build.resize = metered;
        options.build.resize_user = s;
    }
    need(pbwt_open(&tile, s->tree + p, s->summary, s->ranks, &options));
    build(s, &tile, p, &c);
    s->spent.tile += clocked() - start - (s->spent.answer - answered);
    count_slice(s, p, &c);
    count_links(s, &tile, p, &c);
    c.of[BYTES] = (double)tile.numbers.sent_bytes;
    c.of[HALO] = (double)tile.numbers.halo;
    c.of[LATER] = (double)tile.numbers.later;
    c.of[ROUNDS] = (double)tile.numbers.rounds;
    c.of[QUESTIONS] = (double)tile.numbers.questions;
    c.of[PATCH] = (double)tile.numbers.patch_points;
    c.of[MEMORY] = s->of < s->ranks ? (double)s->peak : 0;
    s->sums.points += tile.hash.points;
    s->sums.simplices += tile.hash.simplices;
    pbwt_close(&tile);
    return c;
}

/* What the ranks took beside one triangulation by one thread. */
static void compare(const study *s)
{
    const double all = s->spent.tree + s->spent.tile + s->spent.answer;
    double start = clocked(), one;
    pbw_options serial;
    pbw_mesh mesh;
    uint64_t hash;
    memset(&serial, 0, sizeof serial);
    serial.threads = 1;
    need(pbw_triangulate(3, s->x, NULL, s->n, &serial, &mesh));
    one = clocked() - start;
    start = clocked();
    hash = pbw_hash(&mesh, &serial);
    printf("  one triangulation %.2f s, its hash %.2f s; ranks %.2f s: trees %.2f, tiles %.2f, answers %.2f\n", one,
           clocked() - start, all, s->spent.tree, s->spent.tile, s->spent.answer);
    printf("  ratio %.3f; hashes %s\n", all / one,
           hash == pbw_hash_of(&s->sums) ? "agree" : "DIFFER: were points given up?");
    pbw_free(&mesh);
}

static void report(study *s)
{
    double sum[COUNTS] = { 0 }, most[COUNTS] = { 0 };
    int i, k;
    for (i = 0; i < s->of; i++) {
        const count c = work(s, (int)((long)i * s->ranks / s->of));
        for (k = 0; k < COUNTS; k++) {
            sum[k] += c.of[k];
            most[k] = c.of[k] > most[k] ? c.of[k] : most[k];
        }
    }
    if (s->shell > 0) {
        printf("one rank of %zu points, with others on all sides\n", s->tree[0].count);
    } else {
        printf("%d ranks of %zu points, %s; %d of them worked; summaries %.2f MB a rank\n", s->ranks, s->each,
               kind_name(s->kind), s->of, (double)s->ranks * sizeof(pbwt_summary) * 1e-6);
    }
    for (k = 0; k < COUNTS; k++) {
        printf("  %-34s mean %12.1f   most %12.0f\n", names[k], sum[k] / s->of, most[k]);
    }
}

int main(int argc, char **argv)
{
    study s;
    size_t k;
    int i;
    memset(&s, 0, sizeof s);
    s.ranks = argc > 2 ? atoi(argv[1]) : 0;
    s.each = argc > 2 ? (size_t)atol(argv[2]) : 0;
    s.kind = argc > 3 ? kind_of(argv[3]) : 0;
    s.of = argc > 4 ? atoi(argv[4]) : s.ranks < 100 ? s.ranks : 100;
    if (argc == 3 && strcmp(argv[1], "inner") == 0) {
        s.ranks = 7;
        s.of = 1;
        s.shell = 12 / cbrt((double)s.each);
    }
    if (s.ranks < 1 || s.each < 1 || s.kind >= KINDS || s.of < 1 || s.of > s.ranks) {
        fprintf(stderr, "usage: tiles RANKS POINTS_A_RANK [KIND [OF]], or tiles inner POINTS\n");
        return 2;
    }
    s.n = s.shell > 0 ? (size_t)((double)s.each * pow(1 + 2 * s.shell, 3)) : s.each * (size_t)s.ranks;
    s.x = (double *)take(s.n * 3 * sizeof *s.x);
    s.part = (int *)take(s.n * sizeof *s.part);
    s.tree = (pbwt_tree *)take((size_t)s.ranks * sizeof *s.tree);
    s.summary = (pbwt_summary *)take((size_t)s.ranks * sizeof *s.summary);
    fill(s.kind, s.n, s.x);
    for (k = 0; k < 3 * s.n && s.shell > 0; k++) {
        s.x[k] = s.x[k] * (1 + 2 * s.shell) - s.shell;
    }
    plant(&s);
    report(&s);
    for (i = 0; i < s.ranks; i++) {
        pbwt_tree_free(s.tree + i);
    }
    if (s.of == s.ranks) {
        compare(&s);
    }
    free(s.x);
    free(s.part);
    free(s.tree);
    free(s.summary);
    return 0;
}
