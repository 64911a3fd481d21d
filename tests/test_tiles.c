/* test_tiles.c: parts in one process: whatever the cuts and limits, the simplices of all parts together are those of
   one triangulation, and so are their links; sound after every failure. */
#define PBW_TILES_IMPLEMENTATION
#include "pbw_tiles.h"
#include "inputs.h"
#include "meter.h"
#include "test.h"
#include "zoo.h"

enum { MOST_PARTS = 17 };

typedef struct one { uint64_t corner[4]; uint64_t link[4]; } one;            /* links: part << 40 | simplex, or marks */
typedef struct part_out { one *simplex; size_t count; } part_out;

typedef struct run {
    int dim, parts, halt_at;                         /* halt_at: the emit call to fail at, 0 = none */
    size_t count;
    const double *x, *w;
    pbwt_options options;
    pbwt_limits limits;
    int slabs;                                       /* cuts at random places instead of medians */
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
        status = pbwt_tree_make(r->dim, p, mine, n, &r->options.build, r->tree + p);
        if (status == PBW_OK) {
            pbwt_summarise(r->tree + p, r->summary + p);
        }
    }
    free(all);
    return status;
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
            if (r->tile[p].request[q].size > 0) {
                status = pbwt_answer(r->tree + q, &r->served[q][p], r->tile[p].request + q, &r->limits,
                                     r->summary[p].count, &reply);
                status = status != PBW_OK ? status : pbwt_take(r->tile + p, q, reply.data, reply.size);
            }
            pbwt_bytes_free(r->tree + q, &reply);
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
        status = status != PBW_OK ? status : pbwt_finish(r->tile + r->parts, r->dim, r->parts, &known, &r->options);
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
        CHECK(s->link[facets[i].from & 3] == PBWT_NOTHING - 1);
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
        status = pbwt_open(r->tile + p, r->tree + p, r->summary, r->parts, &r->options);
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
            pbwt_served_free(r->tree + p, &r->served[p][q]);
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
    CHECK_EQUAL(status, expected);
    for (p = 0; p < r->parts; p++) {
        duplicates += r->tree[p].duplicates;
    }
    CHECK_EQUAL(duplicates, mesh->duplicate_count);
    CHECK_EQUAL(r->simplices, mesh->simplex_count);
    CHECK(mesh->point_count == 0 || pbw_hash_of(&r->sums) == pbw_hash(mesh, NULL));
    CHECK(links_of_parts(r) == links_of_mesh(mesh, &hull));
    CHECK_EQUAL(r->hull, hull);
    if (test_verbose) {
        test_say("own %zu, halo %zu, later %zu, questions %zu, rounds %zu, patched %zu, given up %zu", r->own, r->halo,
                 r->later, r->questions, r->rounds, r->patched, r->given_up);
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
    static const int parts[] = { 1, 2, 3, 5, 8, 16 };
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

int main(int argc, char **argv)
{
    int kind, dim;
    test_start(argc, argv, 3000);
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            const int slow = kind == INPUT_MOMENT || (kind == INPUT_SPHERE && dim == 3);
            test_kind(kind, dim, slow ? 300 : (size_t)test_count, INPUT_WEIGHTS_ZERO);
        }
    }
    return test_finish();
}
