/* tiles.c: what a rank of many sends and receives, counted and not modelled: real points, real cuts, and the work of
   a few of the ranks, spread over all of them, with answers by the trees of the others.  If all ranks work, also
   their processor time beside that of one triangulation, one thread each, and whether the hashes agree.
   cc -O2 -I. -Iexamples/lib -Itests bench/tiles.c -o tiles -lpthread -lm
   ./tiles RANKS POINTS_A_RANK [KIND [OF]]    KIND: of tests/inputs.h, ellipsoid or torus; OF: how many work */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_TILES_IMPLEMENTATION
#include "pbw_tiles.h"
#include "inputs.h"
#include <stdio.h>
#include <time.h>

typedef struct count { double partners, asked, messages, bytes, halo, later, rounds, questions, patch; } count;
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

/* The points by part, and a tree for each, by one thread; returns the points. */
static double *plant(int ranks, size_t n, int kind, pbwt_tree *tree, pbwt_summary *summary, times *spent)
{
    pbw_options serial;
    double *x = (double *)take(n * 3 * sizeof *x);
    pbwt_point *all = (pbwt_point *)take(n * sizeof *all), *sample, *sorted = (pbwt_point *)take(n * sizeof *all);
    pbwt_cut *cuts = (pbwt_cut *)take((size_t)ranks * sizeof *cuts);
    size_t *first = (size_t *)take(((size_t)ranks + 1) * sizeof *first), i, samples = 0;
    int p, *part = (int *)take(n * sizeof *part);
    memset(&serial, 0, sizeof serial);
    serial.threads = 1;
    fill(kind, n, x);
    for (i = 0; i < n; i++) {
        memcpy(all[i].x, x + 3 * i, sizeof all[i].x);
        all[i].id = i;
    }
    sample = (pbwt_point *)take((size_t)ranks * 64 * sizeof *sample);
    for (i = 0; i < n; i += 1 + n / ((size_t)ranks * 64)) {
        sample[samples++] = all[i];
    }
    pbwt_cut_points(3, sample, samples, ranks, cuts);
    for (i = 0; i < n; i++) {
        part[i] = pbwt_part(3, cuts, ranks, all + i);
        first[part[i] + 1]++;
    }
    for (p = 0; p < ranks; p++) {
        first[p + 1] += first[p];
    }
    for (i = n; i-- > 0;) {
        sorted[--first[part[i] + 1]] = all[i];       /* first[p + 1] becomes the start of part p */
    }
    for (p = 0; p < ranks; p++) {
        const size_t end = p + 2 <= ranks ? first[p + 2] : n;
        const double start = clocked();
        need(pbwt_tree_make(3, p, sorted + first[p + 1], end - first[p + 1], &serial, tree + p));
        pbwt_summarise(tree + p, summary + p);
        spent->tree += clocked() - start;
    }
    free(all);
    free(sorted);
    free(sample);
    free(cuts);
    free(first);
    free(part);
    return x;
}

static count work(int ranks, const pbwt_tree *tree, const pbwt_summary *summary, int p, times *spent,
                  pbw_hash_sums *sums)
{
    const double start = clocked(), answered = spent->answer;
    pbwt_served *served = (pbwt_served *)take((size_t)ranks * sizeof *served);
    pbwt_bytes reply = { NULL, 0 };
    pbwt_options options;
    pbwt_tile tile;
    count c;
    int q, more = 1;
    memset(&c, 0, sizeof c);
    memset(&options, 0, sizeof options);
    options.build.threads = 1;
    need(pbwt_open(&tile, tree + p, summary, ranks, &options));
    while (need(pbwt_ask(&tile, &more)), more) {
        for (q = 0; q < ranks; q++) {
            if (tile.request[q].size > 0) {
                const double asked = clocked();
                need(pbwt_answer(tree + q, served + q, tile.request + q, NULL, summary[p].count, &reply));
                spent->answer += clocked() - asked;
                need(pbwt_take(&tile, q, reply.data, reply.size));
                c.messages += 2;
                pbwt_bytes_free(tree + q, &reply);
            }
        }
    }
    for (q = 0; q < ranks; q++) {
        c.partners += served[q].visits > 0;
        c.asked += served[q].sent > 0;
        pbwt_served_free(tree + q, served + q);
    }
    c.bytes = (double)tile.numbers.sent_bytes;
    c.halo = (double)tile.numbers.halo;
    c.later = (double)tile.numbers.later;
    c.rounds = (double)tile.numbers.rounds;
    c.questions = (double)tile.numbers.questions;
    c.patch = (double)tile.numbers.patch_points;
    sums->points += tile.hash.points;
    sums->simplices += tile.hash.simplices;
    pbwt_close(&tile);
    spent->tile += clocked() - start - (spent->answer - answered);
    free(served);
    return c;
}

/* What the ranks took beside one triangulation by one thread. */
static void compare(const double *x, size_t n, const times *spent, const pbw_hash_sums *sums)
{
    const double all = spent->tree + spent->tile + spent->answer;
    double start = clocked(), one;
    pbw_options serial;
    pbw_mesh mesh;
    uint64_t hash;
    memset(&serial, 0, sizeof serial);
    serial.threads = 1;
    need(pbw_triangulate(3, x, NULL, n, &serial, &mesh));
    one = clocked() - start;
    start = clocked();
    hash = pbw_hash(&mesh, &serial);
    printf("  one triangulation %.2f s, its hash %.2f s; ranks %.2f s: trees %.2f, tiles %.2f, answers %.2f\n", one,
           clocked() - start, all, spent->tree, spent->tile, spent->answer);
    printf("  ratio %.3f; hashes %s\n", all / one, hash == pbw_hash_of(sums) ? "agree" : "DIFFER (leftovers?)");
    pbw_free(&mesh);
}

int main(int argc, char **argv)
{
    static const char *const names[] = { "partners", "partners with points", "messages", "bytes", "halo points",
                                         "points after the first questions", "rounds of questions", "questions",
                                         "points of repairs" };
    const int ranks = argc > 2 ? atoi(argv[1]) : 0, kind = argc > 3 ? kind_of(argv[3]) : 0;
    const int of = argc > 4 ? atoi(argv[4]) : ranks < 100 ? ranks : 100;
    const size_t each = argc > 2 ? (size_t)atol(argv[2]) : 0;
    double sum[9] = { 0 }, most[9] = { 0 }, *x;
    times spent = { 0, 0, 0 };
    pbw_hash_sums sums = { 0, 0 };
    pbwt_tree *tree;
    pbwt_summary *summary;
    int i, k;
    if (ranks < 1 || each < 1 || kind < 0 || kind >= KINDS || of < 1 || of > ranks) {
        fprintf(stderr, "usage: tiles RANKS POINTS_A_RANK [KIND [OF]]\n");
        return 2;
    }
    tree = (pbwt_tree *)take((size_t)ranks * sizeof *tree);
    summary = (pbwt_summary *)take((size_t)ranks * sizeof *summary);
    x = plant(ranks, each * (size_t)ranks, kind, tree, summary, &spent);
    for (i = 0; i < of; i++) {
        const count c = work(ranks, tree, summary, (int)((long)i * ranks / of), &spent, &sums);
        const double value[9] = { c.partners, c.asked, c.messages, c.bytes, c.halo, c.later, c.rounds, c.questions,
                                  c.patch };
        for (k = 0; k < 9; k++) {
            sum[k] += value[k];
            most[k] = value[k] > most[k] ? value[k] : most[k];
        }
    }
    printf("%d ranks of %zu points, %s; %d of them worked; summaries %.2f MB a rank\n", ranks, each, kind_name(kind),
           of, (double)ranks * sizeof(pbwt_summary) * 1e-6);
    for (k = 0; k < 9; k++) {
        printf("  %-34s mean %12.1f   most %12.0f\n", names[k], sum[k] / of, most[k]);
    }
    for (i = 0; i < ranks; i++) {
        pbwt_tree_free(tree + i);
    }
    if (of == ranks) {
        compare(x, each * (size_t)ranks, &spent, &sums);
    }
    free(x);
    free(tree);
    free(summary);
    return 0;
}
