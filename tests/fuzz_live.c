/* fuzz_live.c: small sets of points decoded from bytes, then changes to them in the order of the bytes; after each
   commit the hash of the view is that of a fresh build, and pbw_check finds no fault.  Half of them start from no
   points, the others from the mesh of the points, of which the bytes change some entries: so nothing in its arrays
   may be believed.
       make fuzz            libFuzzer where clang is installed, else random bytes
       cc -O2 -I. -Iexamples/lib -DFUZZ_MAIN tests/fuzz_live.c -o fuzz -lm -lpthread && ./fuzz --count 100000 --seed 1 */
#define PBW_IMPLEMENTATION
#define PBW_CHECK_IMPLEMENTATION
#define PBW_LIVE_IMPLEMENTATION
static double verify_at;
#define PBWL__REBUILD_AT(dim) (1e9)                     /* so few points would always be triangulated again */
#define PBWL__VERIFY_AT(dim) verify_at
#include "pbw_check.h"
#include "pbw_live.h"
#if defined(__clang__)                                 /* coverage of the library is to guide the fuzzer, not ours */
#pragma clang attribute push(__attribute__((no_sanitize("coverage"))), apply_to = function)
#endif
#include "meshes.h"
#include "small.h"
#include "fuzz.h"
#if defined(__clang__)
#pragma clang attribute pop
#endif

/* What should live: numbers and points of small_input, which lives[i] or not. */
typedef struct state {
    small_input in;
    int lives[SMALL_POINTS];
    pbw_index ids[SMALL_POINTS];
} state;

/* NULL, or what is wrong with the view. */
static const char *judge(const state *s, pbw_live *live, const pbw_options *options)
{
    double points[SMALL_POINTS * 3], weights[SMALL_POINTS];
    const size_t dim = (size_t)s->in.dim;
    size_t n = 0;
    int i;
    pbw_mesh fresh, view;
    pbw_report report;
    pbw_status status;
    const char *fault = NULL;
    for (i = 0; i < s->in.count; i++) {
        if (s->lives[i]) {
            memcpy(points + n * dim, s->in.points + (size_t)i * dim, dim * sizeof(double));
            weights[n++] = s->in.weights[i];
        }
    }
    status = pbw_triangulate(s->in.dim, points, s->in.weighted ? weights : NULL, n, options, &fresh);
    if (pbw_live_view(live, &view) != status) {
        fault = "another status";
    } else if (view.simplex_count != fresh.simplex_count || view.hidden_count != fresh.hidden_count
               || view.duplicate_count != fresh.duplicate_count
               || pbw_hash(&view, options) != pbw_hash(&fresh, options)) {
        fault = "another triangulation";
    } else if (pbw_check(&view, options, &report) != PBW_OK || !report.valid) {
        fault = "a fault in the view";
    }
    pbw_free(&fresh);
    pbw_free(&view);
    return fault;
}

/* Changes the points in the order of the bytes. */
static const char *play(state *s, pbw_live *live, const pbw_options *options, const unsigned char *data, size_t size)
{
    const size_t dim = (size_t)s->in.dim;
    const char *fault = NULL;
    size_t at;
    for (at = 0; at < size && at < 96 && fault == NULL; at++) {
        const int i = (data[at] >> 2) % s->in.count, what = data[at] & 3, other = data[(at + 1) % size] % s->in.count;
        double *p = s->in.points + (size_t)i * dim;
        if (what == 3) {
            pbw_status status;
            verify_at = (at & 1) != 0 ? 0.0 : 1e9;       /* moves all at once, or one by one */
            status = pbw_live_commit(live, NULL);
            fault = status == PBW_OK || status == PBW_DEGENERATE ? judge(s, live, options) : "a status";
        } else if (!s->lives[i]) {
            s->lives[i] = 1;
            fault = pbw_live_insert(live, p, s->in.weighted ? s->in.weights + i : NULL, 1, s->ids + i) == PBW_OK
                  ? NULL : "no insertion";
        } else if (what == 0) {
            s->lives[i] = 0;
            fault = pbw_live_remove(live, s->ids + i, 1) == PBW_OK ? NULL : "no removal";
        } else {                                         /* to the place of another, or a short way there */
            size_t k;
            for (k = 0; k < dim; k++) {
                const double q = s->in.points[(size_t)other * dim + k];
                p[k] = what == 1 ? q : p[k] + (q / 16 - p[k] / 16);
            }
            fault = pbw_live_move(live, s->ids + i, p, 1) == PBW_OK ? NULL : "no move";
        }
    }
    return fault;
}

/* A mesh in arrays of just its sizes, so that sanitizers see what is read behind them. */
typedef struct copied {
    pbw_mesh mesh;
    double *points, *weights;
    pbw_index *simplices, *neighbors, *incident, *canonical;
} copied;

static void *copy(const void *from, size_t bytes)
{
    void *to = malloc(bytes + (bytes == 0));
    if (to == NULL) {
        abort();
    }
    if (bytes > 0) {
        memcpy(to, from, bytes);
    }
    return to;
}

static void copy_mesh(copied *to, const pbw_mesh *mesh)
{
    const size_t entries = mesh->simplex_count * (size_t)(mesh->dim + 1) * sizeof(pbw_index), n = mesh->point_count;
    to->mesh = *mesh;
    to->mesh.memory = NULL;
    to->mesh.points = to->points = (double *)copy(mesh->points, n * (size_t)mesh->dim * sizeof(double));
    to->weights = mesh->weights == NULL ? NULL : (double *)copy(mesh->weights, n * sizeof(double));
    to->mesh.weights = to->weights;
    to->mesh.simplices = to->simplices = (pbw_index *)copy(mesh->simplices, entries);
    to->mesh.neighbors = to->neighbors = (pbw_index *)copy(mesh->neighbors, entries);
    to->mesh.incident = to->incident = (pbw_index *)copy(mesh->incident, n * sizeof(pbw_index));
    to->mesh.canonical = to->canonical = (pbw_index *)copy(mesh->canonical, n * sizeof(pbw_index));
}

static void copied_free(copied *c)
{
    free(c->points);
    free(c->weights);
    free(c->simplices);
    free(c->neighbors);
    free(c->incident);
    free(c->canonical);
}

/* A number below `count`, PBW_NONE, or one that is too large. */
static pbw_index any_number(size_t count, unsigned byte)
{
    const size_t most = count + (byte % 16 == 14 || count == 0);
    return byte % 16 == 15 ? PBW_NONE - byte / 16 % 4 : (pbw_index)(byte / 3 % most);
}

/* Changes simplex t, of which k and j are corners. */
static void damage_simplex(copied *c, unsigned what, size_t t, size_t k, size_t j, unsigned byte)
{
    const size_t corners = (size_t)c->mesh.dim + 1, count = c->mesh.simplex_count, other = byte % count;
    pbw_index *v = c->simplices + t * corners, *next = c->neighbors + t * corners, old;
    size_t i;
    switch (what) {
    case 0: v[k] = v[j]; break;
    case 1: v[k] = any_number(c->mesh.point_count, byte); break;
    case 2: next[k] = next[j]; break;
    case 3: next[k] = any_number(count, byte); break;
    case 4:                                              /* its mirror image, or turned with its neighbors */
        old = v[k], v[k] = v[j], v[j] = old;
        old = next[k], next[k] = next[j], next[j] = byte & 1 ? next[k] : old;
        break;
    case 5:                                              /* another one again */
        memcpy(v, c->simplices + other * corners, corners * sizeof *v);
        memcpy(next, c->neighbors + other * corners, (byte & 64 ? corners : 0) * sizeof *next);
        break;
    case 6:                                              /* alone, or with a hole in its place */
        for (i = 0; i < corners * count; i++) {
            c->neighbors[i] = c->neighbors[i] == t || (byte & 1 && i / corners == t) ? PBW_NONE : c->neighbors[i];
        }
        break;
    default:                                             /* itself on its other side */
        next[k] = (pbw_index)t;
        v[k] = byte & 1 ? v[j] : v[k];
    }
}

/* Changes points p and q. */
static void damage_points(copied *c, unsigned what, size_t p, size_t q, unsigned byte)
{
    const size_t dim = (size_t)c->mesh.dim, entries = c->mesh.simplex_count * (dim + 1);
    size_t k;
    switch (what) {
    case 0: c->canonical[p] = any_number(c->mesh.point_count, byte); break;
    case 1: c->incident[p] = any_number(c->mesh.simplex_count, byte); break;
    case 2: c->canonical[p] = (pbw_index)p; break;       /* no duplicate any more, but hidden if the byte says so */
    case 3: c->incident[p] = byte & 1 ? PBW_NONE : c->incident[q]; break;
    case 4: case 5:                                      /* to the place of another, or a short way there */
        for (k = 0; k < dim; k++) {
            const double x = c->points[p * dim + k], y = c->points[q * dim + k];
            c->points[p * dim + k] = what == 4 ? y : x + (y / 64 - x / 64);
        }
        break;
    case 6:
        if (c->weights != NULL) {
            c->weights[p] = byte & 1 ? c->weights[q] : c->weights[p] + byte;
        }
        break;
    default:                                             /* p instead of q everywhere, or in exchange */
        for (k = 0; k < entries; k++) {
            c->simplices[k] = c->simplices[k] == q ? (pbw_index)p
                            : c->simplices[k] == p && byte & 1 ? (pbw_index)q : c->simplices[k];
        }
        c->incident[p] = c->incident[q];
    }
}

/* Changes entries of the arrays, as the last bytes say; then the input is what the arrays say. */
static void damage(state *s, copied *c, const unsigned char *data, size_t size)
{
    const size_t n = c->mesh.point_count, dim = (size_t)s->in.dim;
    size_t i, changes = data[size - 2] % 5;
    for (i = 0; i < changes && size > 4 * i + 8; i++) {
        const unsigned char *bytes = data + size - 4 * i - 6;
        const unsigned what = bytes[0] % 16;
        if (what >= 8) {
            damage_points(c, what - 8, bytes[1] % n, bytes[2] % n, bytes[3]);
        } else if (c->mesh.simplex_count > 0) {
            damage_simplex(c, what, bytes[1] % c->mesh.simplex_count, bytes[2] % (dim + 1), bytes[2] / 4 % (dim + 1),
                           bytes[3]);
        }
    }
    if (data[size - 2] / 5 % 16 == 0) {
        c->mesh.weights = NULL;
    }
    if (data[size - 2] / 5 % 16 == 1) {
        c->mesh.simplex_count -= c->mesh.simplex_count / 4;
    }
    s->in.weighted = c->mesh.weights != NULL;
    memcpy(s->in.points, c->points, n * dim * sizeof(double));
    for (i = 0; i < n; i++) {
        s->in.weights[i] = s->in.weighted ? c->weights[i] : 0;
        s->lives[i] = c->canonical[i] != PBW_NONE;
        s->ids[i] = (pbw_index)i;
    }
}

/* NULL, or what is wrong with what becomes of the changed mesh of the points. */
static const char *from_mesh(state *s, const pbw_options *options, const unsigned char *data, size_t size)
{
    pbw_mesh mesh;
    pbw_live *live;
    copied c;
    const char *fault;
    pbw_status status = pbw_triangulate(s->in.dim, s->in.points, small_weights(&s->in), (size_t)s->in.count, options,
                                        &mesh);
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        return pbw_status_string(status);
    }
    copy_mesh(&c, &mesh);
    pbw_free(&mesh);
    damage(s, &c, data, size);
    status = pbw_live_create(&c.mesh, options, &live);
    copied_free(&c);
    if (status != PBW_OK && status != PBW_DEGENERATE) {
        return pbw_status_string(status);
    }
    fault = judge(s, live, options);
    fault = fault == NULL ? play(s, live, options, data, size < 24 ? size : 24) : fault;
    pbw_live_free(live);
    return fault;
}

/* NULL, or what is wrong with what becomes of no points and then all of them. */
static const char *begin(state *s, const pbw_options *options, const unsigned char *data, size_t size)
{
    pbw_live *live;
    pbw_mesh none;
    const char *fault;
    int i;
    memset(&none, 0, sizeof none);
    none.dim = s->in.dim;
    if (pbw_live_create(&none, options, &live) != PBW_DEGENERATE) {
        return "not created";
    }
    for (i = 0, fault = NULL; i < s->in.count && fault == NULL; i++) {
        s->lives[i] = 1;
        fault = pbw_live_insert(live, s->in.points + i * s->in.dim, s->in.weighted ? s->in.weights + i : NULL, 1,
                                s->ids + i) == PBW_OK ? NULL : "no insertion";
    }
    fault = fault == NULL ? play(s, live, options, data, size) : fault;
    pbw_live_free(live);
    return fault;
}

static const char *fuzz(const unsigned char *data, size_t size, int print)
{
    pbw_options options;
    state s;
    memset(&options, 0, sizeof options);
    memset(&s, 0, sizeof s);
    small_decode(&s.in, data, size);
    if (s.in.count == 0 || size < 2) {
        return NULL;
    }
    if (print) {
        small_print(&s.in);
    }
    options.threads = 1 + (data[size - 1] % 16 == 1);
    return data[size - 1] & 1 ? from_mesh(&s, &options, data, size) : begin(&s, &options, data, size);
}
