/* fuzz_live.c: small sets of points decoded from bytes, then changes to them in the order of the bytes; after each
   commit the hash of the view is that of a fresh build, and pbw_check finds no fault.
       make fuzz            libFuzzer where clang is installed, else random bytes
       cc -O2 -DFUZZ_MAIN tests/fuzz_live.c -o fuzz -lm -lpthread && ./fuzz --count 100000 --seed 1 */
#define PBW_IMPLEMENTATION
static double verify_at;
#define PBW__REBUILD_AT(dim) (1e9)                     /* so few points would always be triangulated anew */
#define PBW__VERIFY_AT(dim) verify_at
#include "../pbw.h"
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

static const char *fuzz(const unsigned char *data, size_t size, int print)
{
    pbw_options options;
    pbw_live *live;
    pbw_mesh none;
    state s;
    const char *fault;
    memset(&options, 0, sizeof options);
    memset(&none, 0, sizeof none);
    memset(&s, 0, sizeof s);
    options.threads = 1;
    small_decode(&s.in, data, size);
    if (s.in.count == 0 || size == 0) {
        return NULL;
    }
    none.dim = s.in.dim;
    fault = pbw_live_create(&none, &options, &live) == PBW_DEGENERATE ? NULL : "not created";
    if (fault == NULL) {
        int i;
        for (i = 0; i < s.in.count && fault == NULL; i++) {
            s.lives[i] = 1;
            fault = pbw_live_insert(live, s.in.points + i * s.in.dim, s.in.weighted ? s.in.weights + i : NULL, 1,
                                    s.ids + i) == PBW_OK ? NULL : "no insertion";
        }
        fault = fault == NULL ? play(&s, live, &options, data, size) : fault;
        pbw_live_free(live);
    }
    if (print) {
        small_print(&s.in);
    }
    return fault;
}
