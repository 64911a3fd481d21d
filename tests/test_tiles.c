/* test_tiles.c: parts in one process: whatever the cuts and limits, the simplices of all parts together are those of
   one triangulation, and so are their links; sound after every failure. */
#include "pbw_tiles.h"
#include "inputs.h"
#include "meter.h"
#include "test.h"
#include "zoo.h"

enum { MOST_PARTS = 17 };

typedef struct one { uint64_t corner[4], link[4]; } one;             /* links: part << 40 | simplex, or marks */
typedef struct part_out { one *simplex; size_t count; } part_out;

typedef struct run {
    int dim, parts, halt_at;                         /* halt_at: the emit call to fail at, 0 = none */
    size_t count;
    const double *x, *w;
    pbwt_options options;
    pbwt_limits limits;
    int slabs;                                       /* cuts at random places instead of medians */
    int giving;                                      /* 1 + the part that gives up all points it would ask about */
    const pbw_options *limited;                      /* of part 0, or of the leftovers; NULL: as the others */
    int last_is_limited;
    pbwt_tree tree[MOST_PARTS];
    pbwt_summary summary[MOST_PARTS];
    pbwt_served served[MOST_PARTS][MOST_PARTS];
    pbwt_tile tile[MOST_PARTS + 1];
    part_out out[MOST_PARTS + 1];
    pbw_hash_sums sums;
    size_t simplices, hull, given_up, rounds, halo, own, later, questions, patched;
} run;

static pbw_status collect(void *user, const pbwt_tile *tile, size_t first, size_t count, const uint32_t *corners,
                          const uint32_t *links)
{
    run *r = (run *)user;
    const int part = tile->tree != NULL ? tile->tree->part : r->parts;
    part_out *out = r->out + part;
    const size_t own = tile->tree != NULL ? tile->tree->count : 0;
    size_t i;
    int k;
    if (r->halt_at > 0 && --r->halt_at == 0) {
        return PBW_ERROR_BACKEND;
    }
    CHECK_EQUAL(first, out->count);
    out->simplex = (one *)zoo_grow(out->simplex, (out->count + count) * sizeof(one));
    for (i = 0; i < count; i++) {
        one *s = out->simplex + out->count++;
        memset(s, 0, sizeof *s);
        for (k = 0; k <= r->dim; k++) {
            const uint32_t c = corners[i * (size_t)(r->dim + 1) + (size_t)k];
            const uint32_t l = links[i * (size_t)(r->dim + 1) + (size_t)k];
            s->corner[k] = c < own ? tile->tree->points[c].id : tile->foreign[c - own].point.id;
            s->link[k] = l == PBWT_HULL || l == PBWT_OPEN ? PBWT_NOTHING - (l == PBWT_OPEN)
                       : (uint64_t)part << 40 | l;
        }
    }
    return PBW_OK;
}

static pbwt_point point_of(const run *r, size_t i)
{
    pbwt_point p;
    memset(&p, 0, sizeof p);
    memcpy(p.x, r->x + i * (size_t)r->dim, (size_t)r->dim * sizeof(double));
    p.weight = r->w != NULL ? r->w[i] : 0;
    p.id = i * 3 + 5;
    return p;
}

static const pbw_options *build_of(const run *r, int part)
{
    return r->limited != NULL && part == (r->last_is_limited ? r->parts : 0) ? r->limited : &r->options.build;
}

static pbw_status split(run *r)
{
    pbwt_cut cuts[MOST_PARTS];
    pbwt_point *all = (pbwt_point *)zoo_grow(NULL, (2 * r->count + 1) * sizeof *all), *mine = all + r->count;
    size_t i, n;
    uint64_t state = test_seed;
    pbw_status status = PBW_OK;
    int p;
    for (i = 0; i < r->count; i++) {
        all[i] = point_of(r, i);
    }
    /* medians of all points, or of very few of them: parts of any size, and empty ones */
    n = r->slabs ? 1 + input_below(&state, (uint32_t)(2 * r->parts)) : r->count;
    pbwt_cut_points(r->dim, all, n < r->count ? n : r->count, r->parts, cuts);
    for (p = 0; p < r->parts && status == PBW_OK; p++) {
        for (i = n = 0; i < r->count; i++) {
            const pbwt_point q = point_of(r, i);
            if (pbwt_part(r->dim, cuts, r->parts, &q) == p) {
                mine[n++] = q;
            }
        }
        status = pbwt_tree_make(r->dim, p, mine, n, build_of(r, p), r->tree + p);
        if (status == PBW_OK) {
            pbwt_summarise(r->tree + p, r->summary + p);
        }
    }
    free(all);
    return status;
}

/* A tree as it answers to others, beyond the limit of its tile. */
static pbwt_tree answering(const run *r, int part)
{
    pbwt_tree tree = r->tree[part];
    tree.options = r->options.build;
    return tree;
}

/* A round: all ask, all answer, all take. */
static pbw_status exchange(run *r, int *more)
{
    pbw_status status = PBW_OK;
    pbwt_bytes reply = { NULL, 0 };
    int p, q, any;
    *more = 0;
    for (p = 0; p < r->parts && status == PBW_OK; p++) {
        status = pbwt_ask(r->tile + p, &any);
        *more |= any;
    }
    for (p = 0; p < r->parts && status == PBW_OK && *more; p++) {
        for (q = 0; q < r->parts && status == PBW_OK; q++) {
            const pbwt_tree tree = answering(r, q);
            if (r->tile[p].request[q].size > 0) {
                status = pbwt_answer(&tree, &r->served[q][p], r->tile[p].request + q, &r->limits,
                                     r->summary[p].count, &reply);
                status = status != PBW_OK ? status : pbwt_take(r->tile + p, q, reply.data, reply.size);
            }
            pbwt_bytes_free(&tree, &reply);
        }
    }
    return status;
}

static int id_order(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

static pbw_status leftovers(run *r)
{
    uint64_t *ids = NULL;
    pbwt_bytes known = { NULL, 0 }, piece;
    pbwt_options options = r->options;
    size_t n = 0, i;
    pbw_status status = PBW_OK;
    int p;
    for (p = 0; p < r->parts; p++) {
        ids = (uint64_t *)zoo_grow(ids, (n + r->tile[p].leftover_count + 1) * sizeof *ids);
        for (i = 0; i < r->tile[p].leftover_count; i++) {
            ids[n++] = r->tree[p].points[r->tile[p].leftovers[i]].id;
        }
    }
    r->given_up = n;
    if (n > 0) {
        qsort(ids, n, sizeof *ids, id_order);
        for (p = 0; p < r->parts && status == PBW_OK; p++) {
            status = pbwt_leftovers(r->tile + p, ids, n, &piece);
            if (status == PBW_OK) {
                known.data = (char *)zoo_grow(known.data, known.size + piece.size + 1);
                memcpy(known.data + known.size, piece.data, piece.size);
                known.size += piece.size;
                pbwt_bytes_free(r->tree + p, &piece);
            }
        }
        options.build = *build_of(r, r->parts);
        status = status != PBW_OK ? status : pbwt_finish(r->tile + r->parts, r->dim, r->parts, &known, &options);
    }
    free(known.data);
    free(ids);
    return status;
}

static void link_parts(run *r)
{
    pbwt_facet *facets = NULL;
    size_t n = 0, i;
    int p;
    for (p = 0; p <= r->parts; p++) {
        r->hull += r->tile[p].numbers.hull;
        if (r->tile[p].facet_count > 0) {
            facets = (pbwt_facet *)zoo_grow(facets, (n + r->tile[p].facet_count) * sizeof *facets);
            memcpy(facets + n, r->tile[p].facets, r->tile[p].facet_count * sizeof *facets);
            n += r->tile[p].facet_count;
        }
    }
    r->hull += pbwt_match(facets, n);
    for (i = 0; i < n; i++) {
        one *s = r->out[facets[i].from >> 40].simplex + ((facets[i].from & 0xffffffffffu) >> 2);
        CHECK(s->link[facets[i].from & 3] == PBWT_NOTHING - 1 && (i == 0 || facets[i - 1].from < facets[i].from));
        s->link[facets[i].from & 3] = facets[i].to == PBWT_NOTHING ? PBWT_NOTHING
            : (facets[i].to >> 40) << 40 | (facets[i].to & 0xffffffffffu) >> 2;
    }
    free(facets);
}

static pbw_status run_all(run *r)
{
    pbw_status status;
    int p, more = 1;
    r->options.emit = collect;
    r->options.emit_user = r;
    r->options.weighted = r->w != NULL;
    status = split(r);
    for (p = 0; p < r->parts && status == PBW_OK; p++) {
        pbwt_options options = r->options;
        options.questions = p + 1 == r->giving ? 1e-9 : options.questions;
        options.build = *build_of(r, p);
        status = pbwt_open(r->tile + p, r->tree + p, r->summary, r->parts, &options);
    }
    while (status == PBW_OK && more) {
        status = exchange(r, &more);
    }
    status = status != PBW_OK ? status : leftovers(r);
    for (p = 0; p <= r->parts; p++) {
        const pbwt_numbers *n = &r->tile[p].numbers;
        r->sums.points += r->tile[p].hash.points;
        r->sums.simplices += r->tile[p].hash.simplices;
        r->simplices += n->simplices;
        r->rounds = n->rounds > r->rounds ? n->rounds : r->rounds;
        r->halo += n->halo;
        r->later += n->later;
        r->questions += n->questions;
        r->patched += n->patch_points;
        r->own += p < r->parts ? r->tree[p].count : 0;
    }
    if (status == PBW_OK) {
        link_parts(r);
    }
    return status;
}

static void run_free(run *r)
{
    int p, q;
    for (p = 0; p <= r->parts; p++) {
        pbwt_close(r->tile + p);
        free(r->out[p].simplex);
        for (q = 0; p < r->parts && q < r->parts; q++) {
            const pbwt_tree tree = answering(r, p);
            pbwt_served_free(&tree, &r->served[p][q]);
        }
    }
    for (p = 0; p < r->parts; p++) {
        pbwt_tree_free(r->tree + p);
    }
    free(r);
}

static run *run_new(int dim, const double *x, const double *w, size_t count, int parts)
{
    run *r = (run *)zoo_grow(NULL, sizeof *r);
    memset(r, 0, sizeof *r);
    r->dim = dim;
    r->x = x;
    r->w = w;
    r->count = count;
    r->parts = parts;
    r->options.build.threads = 1;
    return r;
}

/* ---- comparison */

/* A number for a simplex, from the set of its corners' ids. */
static uint64_t key_of(const one *s, int dim)
{
    uint64_t key = 0;
    int k;
    for (k = 0; k <= dim; k++) {
        uint64_t state = s->corner[k];
        key += input_next(&state);
    }
    return key;
}

/* The sum over all pairs of simplex and neighbour, and over facets of the hull. */
static uint64_t mixed(uint64_t simplex, uint64_t neighbor)
{
    uint64_t state = simplex * 3 + neighbor;
    return input_next(&state);
}

static uint64_t links_of_parts(const run *r)
{
    uint64_t sum = 0;
    size_t i;
    int p, k;
    for (p = 0; p <= r->parts; p++) {
        for (i = 0; i < r->out[p].count; i++) {
            const one *s = r->out[p].simplex + i;
            for (k = 0; k <= r->dim; k++) {
                const uint64_t link = s->link[k];
                sum += mixed(key_of(s, r->dim), link == PBWT_NOTHING ? 0
                             : key_of(r->out[link >> 40].simplex + (link & 0xffffffffffu), r->dim));
            }
        }
    }
    return sum;
}

static uint64_t key_of_mesh(const pbw_mesh *mesh, pbw_index simplex)
{
    one s;
    int k;
    for (k = 0; k <= mesh->dim; k++) {
        s.corner[k] = (uint64_t)mesh->simplices[(size_t)simplex * (size_t)(mesh->dim + 1) + (size_t)k] * 3 + 5;
    }
    return key_of(&s, mesh->dim);
}

static uint64_t links_of_mesh(const pbw_mesh *mesh, size_t *hull)
{
    uint64_t sum = 0;
    size_t i;
    int k;
    *hull = 0;
    for (i = 0; i < mesh->simplex_count; i++) {
        for (k = 0; k <= mesh->dim; k++) {
            const pbw_index n = mesh->neighbors[i * (size_t)(mesh->dim + 1) + (size_t)k];
            *hull += n == PBW_NONE;
            sum += mixed(key_of_mesh(mesh, (pbw_index)i), n == PBW_NONE ? 0 : key_of_mesh(mesh, n));
        }
    }
    return sum;
}

static void compare(run *r, pbw_status status, const pbw_mesh *mesh, pbw_status expected)
{
    size_t hull, duplicates = 0;
    int p;
    if (!CHECK_EQUAL(status, expected)) {
        return;
    }
    for (p = 0; p < r->parts; p++) {
        duplicates += r->tree[p].duplicates;
    }
    CHECK_EQUAL(duplicates, mesh->duplicate_count);
    CHECK_EQUAL(r->simplices, mesh->simplex_count);
    CHECK(mesh->point_count == 0 || pbw_hash_of(&r->sums) == pbw_hash(mesh, NULL));
    CHECK(links_of_parts(r) == links_of_mesh(mesh, &hull));
    CHECK_EQUAL(r->hull, hull);
    if (test_verbose) {
        test_say("own %zu, halo %zu, later %zu, questions %zu, rounds %zu, patched %zu, given up %zu", r->own,
                 r->halo, r->later, r->questions, r->rounds, r->patched, r->given_up);
    }
}

static void try(run *r, const pbw_mesh *mesh, pbw_status expected)
{
    compare(r, run_all(r), mesh, expected);
    run_free(r);
}

/* ---- tests */

static void test_kind(int kind, int dim, size_t count, int weights)
{
    static const int parts[] = { 1, 2, 5, 16 };
    double *x = (double *)zoo_grow(NULL, count * (size_t)dim * sizeof *x), *w = NULL;
    pbw_mesh mesh;
    pbw_status status;
    size_t i;
    input_fill(kind, dim, count, test_seed, x);
    if (weights != INPUT_WEIGHTS_ZERO) {
        w = (double *)zoo_grow(NULL, count * sizeof *w);
        input_fill_weights(weights, dim, count, test_seed, x, w);
    }
    status = pbw_triangulate(dim, x, w, count, NULL, &mesh);
    for (i = 0; i < sizeof parts / sizeof *parts; i++) {
        if (test_begin("%s %dD %s, %zu points in %d parts", input_name(kind), dim, input_weights_name(weights), count,
                       parts[i])) {
            try(run_new(dim, x, w, count, parts[i]), &mesh, status);
            test_end();
        }
    }
    pbw_free(&mesh);
    free(x);
    free(w);
}

/* For every input of the zoo one of, small ones three: usual limits, no halo, answers of few points, no work, few
   questions; half of them with any cuts. */
static void force(run *r, size_t how)
{
    if (how % 5 == 1) {
        r->options.halo = -1;
    } else if (how % 5 == 2) {
        r->options.halo = 0.5;
        r->limits.answer = 1 + how % 4;
        r->limits.halo_answer = 3;
    } else if (how % 5 == 4) {
        r->options.questions = 0.05 * (double)(how % 7);
    } else if (how % 5 == 3) {
        r->limits.work = 1;
        r->limits.points = 1 + how % 20;
    }
    r->slabs = how % 2 != 0;
}

static void test_zoo(void)
{
    zoo z;
    size_t i, how;
    zoo_fill(&z);
    for (i = 0; i < z.count; i++) {
        const zoo_input *in = z.items + i;
        pbw_mesh mesh;
        pbw_status status;
        if (!in->finite || !test_begin("zoo: %s", in->name)) {
            continue;
        }
        status = pbw_triangulate(in->dim, in->points, in->weights, in->count, NULL, &mesh);
        for (how = 0; how < (in->count <= 12 ? 3u : 1u); how++) {
            run *r = run_new(in->dim, in->points, in->weights, in->count, 2 + (int)((i + 3 * how) % 7));
            force(r, i + 3 * how);
            try(r, &mesh, in->count == 0 ? PBW_OK : status);
        }
        pbw_free(&mesh);
        test_end();
    }
    zoo_free(&z);
}

/* Uniform, gauss and the others again with forced limits, any cuts, weights and duplicates. */
static void test_forced(int dim, size_t count)
{
    static const int kinds[] = { INPUT_UNIFORM, INPUT_CLUSTERS, INPUT_LATTICE, INPUT_SPHERE, INPUT_SPIRAL };
    size_t i, how, k;
    for (k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        for (how = 0; how < INPUT_WEIGHTS_KINDS; how++) {
            const int kind = kinds[k];
            double *x, *w;
            pbw_mesh mesh;
            pbw_status status;
            run *r;
            if (!test_begin("forced %zu: %dD %s %s", how, dim, input_name(kind), input_weights_name((int)how))) {
                continue;
            }
            x = (double *)zoo_grow(NULL, count * (size_t)dim * sizeof *x);
            w = (double *)zoo_grow(NULL, count * sizeof *w);
            input_fill(kind, dim, count, test_seed, x);
            input_fill_weights((int)how, dim, count, test_seed, x, w);
            for (i = 0; i < count / 10 * (size_t)dim; i++) {         /* a tenth lies at places taken before */
                x[count * (size_t)dim - 1 - i] = x[count / 2 * (size_t)dim - 1 - i];
            }
            status = pbw_triangulate(dim, x, how % 3 == 0 ? NULL : w, count, NULL, &mesh);
            r = run_new(dim, x, how % 3 == 0 ? NULL : w, count, 2 + (int)((k + how) % 15));
            force(r, k + how);
            r->options.build.threads = how % 4 == 0 ? 2 : 1;
            try(r, &mesh, status);
            pbw_free(&mesh);
            free(x);
            free(w);
            test_end();
        }
    }
}

/* Points that are hidden, given up by some parts only: among the leftovers they may show up, and must not count. */
static void test_hidden(int dim)
{
    if (test_begin("hidden points among leftovers, %dD", dim)) {
        double x[200 * 3], w[200];
        uint64_t seed;
        for (seed = 1; seed <= 40; seed++) {
            const size_t count = 60 + seed * 3;
            const int weights = seed % 2 != 0 ? INPUT_WEIGHTS_GIANT : INPUT_WEIGHTS_HALF;
            pbw_mesh mesh;
            pbw_status status;
            run *r;
            input_fill(INPUT_UNIFORM, dim, count, seed, x);
            input_fill_weights(weights, dim, count, seed, x, w);
            status = pbw_triangulate(dim, x, w, count, NULL, &mesh);
            r = run_new(dim, x, w, count, 3 + (int)(seed % 6));
            r->giving = 1 + (int)(seed / 2) % r->parts;
            r->options.halo = -1;
            try(r, &mesh, status);
            pbw_free(&mesh);
        }
        test_end();
    }
}

/* So many balls touch the other part that a sample of them tells: all is given up before anything is asked. */
static void test_surface(void)
{
    if (test_begin("a surface: given up without questions")) {
        const size_t count = 24000;
        double *x = (double *)zoo_grow(NULL, count * 3 * sizeof *x);
        size_t i, questions = 0;
        pbw_mesh mesh;
        pbw_status status;
        run *r = run_new(3, x, NULL, count, 2);
        input_fill(INPUT_SPHERE, 3, count, test_seed, x);
        for (i = 0; i < count; i++) {
            x[3 * i] *= 0.5;
        }
        status = pbw_triangulate(3, x, NULL, count, NULL, &mesh);
        r->options.questions = 0.1;
        compare(r, run_all(r), &mesh, status);
        for (i = 0; i < 2; i++) {
            questions += r->tile[i].numbers.questions;
        }
        CHECK_EQUAL(questions, 0);
        CHECK_EQUAL(r->given_up, count);
        run_free(r);
        pbw_free(&mesh);
        free(x);
        test_end();
    }
}

/* ---- failures */

static run *failing_run(const double *x, const double *w, meter *m)
{
    run *r = run_new(3, x, w, 90, 3);
    r->options.build.resize = meter_resize;
    r->options.build.resize_user = m;
    r->options.halo = 0.3;
    return r;
}

static void test_memory(int work)
{
    if (test_begin("failures: memory%s", work > 0 ? ", with leftovers" : "")) {
        double x[90 * 3], w[90];
        pbw_status status = PBW_ERROR_MEMORY;
        meter m;
        long k;
        input_fill(INPUT_CLUSTERS, 3, 90, test_seed, x);
        input_fill_weights(INPUT_WEIGHTS_HIDING, 3, 90, test_seed, x, w);
        for (k = 1; status == PBW_ERROR_MEMORY && k < 100000; k++) {
            run *r;
            meter_start(&m, k, k % 2 != 0);
            r = failing_run(x, w, &m);
            r->limits.work = (size_t)work;
            status = run_all(r);
            CHECK(status == PBW_OK || status == PBW_ERROR_MEMORY);
            run_free(r);
            CHECK(m.blocks == 0 && m.bytes == 0 && m.faults == 0);
        }
        CHECK_EQUAL(status, PBW_OK);
        CHECK(k > 100);
        test_end();
    }
}

static int stop(void *user, pbw_stage stage, double done)
{
    (void)stage;
    (void)done;
    return --*(long *)user == 0;
}

static void test_stops(void)
{
    if (test_begin("failures: cancelled, the caller's, limits, messages")) {
        double x[90 * 3];
        long k, left;
        pbw_status status = PBW_CANCELLED;
        meter m;
        run *r;
        pbwt_bytes bad;
        char text[64];
        input_fill(INPUT_UNIFORM, 3, 90, test_seed, x);
        meter_start(&m, 0, 0);
        for (k = 1; status == PBW_CANCELLED && k < 10000; k++) {
            left = k;
            r = failing_run(x, NULL, &m);
            r->options.build.progress = stop;
            r->options.build.progress_user = &left;
            status = run_all(r);
            run_free(r);
            CHECK(m.blocks == 0 && m.faults == 0);
        }
        CHECK(status == PBW_OK && k > 10);
        r = failing_run(x, NULL, &m);
        r->halt_at = 2;
        CHECK_EQUAL(run_all(r), PBW_ERROR_BACKEND);
        run_free(r);
        r = failing_run(x, NULL, &m);
        r->options.build.memory_limit = 30000;
        CHECK_EQUAL(run_all(r), PBW_ERROR_MEMORY);
        CHECK(m.peak < 3 * 31000 + 3 * 90000);
        run_free(r);
        r = failing_run(x, NULL, &m);
        CHECK_EQUAL(split(r), PBW_OK);
        memset(text, 7, sizeof text);
        bad.data = text;
        for (bad.size = 0; bad.size < sizeof text; bad.size++) {
            pbwt_bytes reply = { NULL, 0 };
            CHECK_EQUAL(pbwt_answer(r->tree, &r->served[0][1], &bad, NULL, 30, &reply), PBW_ERROR_ARGUMENT);
        }
        CHECK_EQUAL(pbwt_open(r->tile, r->tree, r->summary, 3, &r->options), PBW_OK);
        CHECK_EQUAL(pbwt_take(r->tile, 1, text, sizeof text), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(pbwt_take(r->tile, 3, text, sizeof text), PBW_ERROR_ARGUMENT);
        run_free(r);
        CHECK(m.blocks == 0);
        x[5] = HUGE_VAL;
        r = failing_run(x, NULL, &m);
        CHECK_EQUAL(run_all(r), PBW_ERROR_NOT_FINITE);
        run_free(r);
        test_end();
    }
}

/* A run of a tile and others: what the tile and its tree hold is counted, or what the leftovers hold. */
static pbw_status limited_run(const double *x, const double *w, size_t count, int last, const pbw_options *options,
                              uint64_t *hash)
{
    run *r = run_new(3, x, w, count, 3);
    pbw_status status;
    r->options.weighted = w != NULL;
    r->options.halo = 0.3;
    r->giving = last ? 1 : 0;
    r->limits.work = last ? 1 : 0;
    r->limited = options;
    r->last_is_limited = last;
    status = run_all(r);
    *hash = r->sums.simplices + r->sums.points;
    CHECK(!last || status != PBW_OK || r->given_up > 0);
    run_free(r);
    return status;
}

/* At 30 levels of options.memory_limit a tile holds at most that, and is the same or PBW_ERROR_MEMORY. */
static void test_levels(int kind, int weights, int last)
{
    if (test_begin("memory limit: %s, weights %s%s", input_name(kind), input_weights_name(weights),
                   last ? ", leftovers" : "")) {
        enum { COUNT = 900 };
        double x[COUNT * 3], w[COUNT];
        pbw_options options;
        uint64_t hash, other;
        size_t most, k, failed = 0;
        meter m;
        memset(&options, 0, sizeof options);
        options.threads = 1;
        options.resize = meter_resize;
        options.resize_user = &m;
        input_fill(kind, 3, COUNT, test_seed, x);
        input_fill_weights(weights, 3, COUNT, test_seed, x, w);
        meter_start(&m, 0, 0);
        CHECK_EQUAL(limited_run(x, weights != INPUT_WEIGHTS_ZERO ? w : NULL, COUNT, last, &options, &hash), PBW_OK);
        most = m.peak;
        for (k = 1; k <= 30; k++) {                  /* to 1.5 times what it holds without a limit */
            pbw_status status;
            options.memory_limit = most * k / 20;
            meter_start(&m, 0, 0);
            status = limited_run(x, weights != INPUT_WEIGHTS_ZERO ? w : NULL, COUNT, last, &options, &other);
            CHECK(status == PBW_OK ? hash == other : status == PBW_ERROR_MEMORY);
            if (!CHECK(m.peak <= options.memory_limit && m.blocks == 0 && m.faults == 0)) {
                test_say("%.3f of the limit", (double)m.peak / (double)options.memory_limit);
            }
            failed += status != PBW_OK;
        }
        test_say("holds %lu bytes; %lu of 30 limits suffice", (unsigned long)most, (unsigned long)(30 - failed));
        CHECK(failed >= 15 && failed < 30);
        test_end();
    }
}

int main(int argc, char **argv)
{
    int kind, dim;
    size_t count;
    test_start(argc, argv, 2000);
    count = (size_t)test_count / 2;
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            const int slow = kind == INPUT_MOMENT || (kind == INPUT_SPHERE && dim == 3);
            test_kind(kind, dim, slow ? 300 : count, INPUT_WEIGHTS_ZERO);
        }
        test_kind(INPUT_UNIFORM, dim, count, INPUT_WEIGHTS_HIDING);
        test_kind(INPUT_CLUSTERS, dim, count, INPUT_WEIGHTS_HALF);
        test_forced(dim, dim == 2 ? 400 : 200);
        test_hidden(dim);
    }
    test_surface();
    test_zoo();
    test_memory(0);
    test_memory(1);
    test_stops();
    test_levels(INPUT_UNIFORM, INPUT_WEIGHTS_ZERO, 0);
    test_levels(INPUT_CLUSTERS, INPUT_WEIGHTS_HALF, 0);
    test_levels(INPUT_SPHERE, INPUT_WEIGHTS_ZERO, 1);
    return test_finish();
}
