/* test_clip.c: cells in the plane clipped by polygons: equal to brute force, whole, closed, exact where polygons lie
   along sides of cells, the same bytes for every number of threads, and sound after every failure. */
#include "pbw_cells.h"
#include "inputs.h"
#include "meter.h"
#include "test.h"
#include "zoo.h"
#include <math.h>

#define ALL (PBW_CELLS_FACETS | PBW_CELLS_SHAPES)

enum { MOST_CORNERS = 4096, MOST_RINGS = 64 };
typedef struct polygon { double x[2 * MOST_CORNERS]; size_t first[MOST_RINGS + 1], rings, corners; } polygon;

static void polygon_start(polygon *p)
{
    p->rings = p->corners = p->first[0] = 0;
}

static void add(polygon *p, double x, double y)
{
    p->x[2 * p->corners] = x;
    p->x[2 * p->corners++ + 1] = y;
}

static void close_ring(polygon *p)
{
    p->first[++p->rings] = p->corners;
}

static void add_box(polygon *p, double x0, double y0, double x1, double y1)
{
    add(p, x0, y0), add(p, x1, y0), add(p, x1, y1), add(p, x0, y1);
    close_ring(p);
}

/* ---- polygons in the unit square */

enum { STAR, COMB, HOLES, TOUCHING, POINTS_ON_EDGES, TINY, SPIRAL, POLYGONS };
static const char *const polygon_names[POLYGONS] = { "star", "comb", "holes and islands", "touching rings",
                                                     "collinear edges", "tiny", "spiral" };

static void make_star(polygon *p, int corners, uint64_t *state)
{
    int i;
    for (i = 0; i < corners; i++) {
        const double r = 0.1 + 0.4 * input_uniform(state);
        double c, s;
        input_turn((i + 0.5) / corners, &c, &s);
        add(p, 0.5 + r * c, 0.5 + r * s);
    }
    close_ring(p);
}

static void make_comb(polygon *p, int teeth)
{
    int i;
    add(p, 1, 0), add(p, 1, 1);
    for (i = teeth; i-- > 0; ) {
        add(p, (i + 0.5) / teeth, 1.0 / 16), add(p, (i + 0.25) / teeth, 15.0 / 16);
    }
    add(p, 0, 0);
    close_ring(p);
}

static void make_spiral(polygon *p, int turns)
{
    const int steps = 24 * turns;
    int i;
    double c, s;
    for (i = 0; i <= 2 * steps; i++) {
        const int k = i < steps ? i : 2 * steps - i;
        const double r = 0.5 * (k + (i < steps ? 0 : 8)) / (steps + 9);
        input_turn(k % 24 / 24.0, &c, &s);
        add(p, 0.5 + r * c, 0.5 + r * s);
    }
    close_ring(p);
}

static void polygon_make(polygon *p, int kind, uint64_t *state)
{
    int i, j;
    polygon_start(p);
    if (kind == STAR) {
        make_star(p, 60, state);
    } else if (kind == COMB) {
        make_comb(p, 40);
    } else if (kind == HOLES) {
        add_box(p, 0, 0, 1, 1);
        for (i = 0; i < 4; i++) {
            for (j = 0; j < 4; j++) {                /* a hole in each of 16 squares, and an island in it */
                const double x = i / 4.0, y = j / 4.0;
                add_box(p, x + 1.0 / 16, y + 1.0 / 16, x + 3.0 / 16, y + 3.0 / 16);
                add_box(p, x + 2.5 / 16, y + 1.5 / 16, x + 1.5 / 16, y + 2.5 / 16);
            }
        }
    } else if (kind == TOUCHING) {
        add_box(p, 0, 0, 1, 1);
        add_box(p, 0.25, 0.25, 0.5, 0.5);
        add_box(p, 0.5, 0.5, 0.75, 0.75);
        add(p, 0, 0.5), add(p, 0.125, 0.625), add(p, 0.125, 0.375);
        close_ring(p);
    } else if (kind == POINTS_ON_EDGES) {
        for (i = 0; i < 256; i++) {
            const double t = i % 64 / 64.0;
            add(p, i < 64 ? t : i < 128 ? 1 : i < 192 ? 1 - t : 0, i < 64 ? 0 : i < 128 ? t : i < 192 ? 1 : 1 - t);
            if (i % 16 == 3) {
                add(p, p->x[2 * p->corners - 2], p->x[2 * p->corners - 1]);
            }
        }
        close_ring(p);
    } else if (kind == TINY) {
        add_box(p, 0.501, 0.502, 0.501 + 1e-5, 0.502 + 1e-5);
        add_box(p, 0.501 + 2e-6, 0.502 + 2e-6, 0.501 + 5e-6, 0.502 + 4e-6);
    } else {
        make_spiral(p, 5);
    }
}

/* Onto a box; margin: how much larger than the box. */
static void polygon_fit(polygon *p, const double *box, double margin)
{
    size_t i;
    for (i = 0; i < 2 * p->corners; i++) {
        const double size = box[2 + i % 2] - box[i % 2];
        p->x[i] = box[i % 2] - margin * size + (1 + 2 * margin) * size * p->x[i];
    }
}

static pbw_domain domain_of(const polygon *p)
{
    pbw_domain domain;
    memset(&domain, 0, sizeof domain);
    domain.rings = p->x;
    domain.ring_first = p->first;
    domain.ring_count = p->rings;
    return domain;
}

/* ---- brute force: the polygon as triangles with signs, between an origin and each edge, each cut by half-planes */

static size_t ring_of(const polygon *p, size_t edge)
{
    size_t r = 0;
    while (p->first[r + 1] <= edge) {
        r++;
    }
    return r;
}

static const double *end_of(const polygon *p, size_t edge)
{
    const size_t r = ring_of(p, edge);
    return p->x + 2 * (edge + 1 < p->first[r + 1] ? edge + 1 : p->first[r]);
}

/* Twice the signed area of a ring, and of the polygon: its rings with signs by how many others they are within. */
static double ring_area(const polygon *p, size_t r)
{
    double sum = 0;
    size_t i;
    for (i = p->first[r]; i < p->first[r + 1]; i++) {
        const double *a = p->x + 2 * i, *b = end_of(p, i), *o = p->x + 2 * p->first[r];
        sum += (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    }
    return sum;
}

/* Is a point inside of the other rings?  By a ray upward. */
static int is_inside(const polygon *p, size_t without, double x, double y)
{
    size_t i;
    int odd = 0;
    for (i = 0; i < p->corners; i++) {
        const double *a = p->x + 2 * i, *b = end_of(p, i);
        if (ring_of(p, i) != without && (a[0] <= x) != (b[0] <= x)) {
            odd ^= a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]) > y;
        }
    }
    return odd;
}

/* 1 or -1 for each ring: with it, edges have the inside on their left. */
static void ring_signs(const polygon *p, double *sign)
{
    size_t r;
    for (r = 0; r < p->rings; r++) {
        const double *a = p->x + 2 * p->first[r], *b = a + 2;
        const int hole = is_inside(p, r, 0.49 * a[0] + 0.51 * b[0], 0.49 * a[1] + 0.51 * b[1]);
        sign[r] = (ring_area(p, r) > 0) != hole ? 1 : -1;
    }
}

static double area_of(const polygon *p)
{
    double sum = 0, sign[MOST_RINGS];
    size_t r;
    ring_signs(p, sign);
    for (r = 0; r < p->rings; r++) {
        sum += sign[r] * ring_area(p, r);
    }
    return sum / 2;
}

enum { PLANES = 400 };
typedef struct brute { size_t count; double plane[PLANES][3]; pbw_index name[PLANES]; } brute;

/* Cuts a polygon (or a segment: count 2) by a half-plane n.x <= c. */
static int cut(double (*x)[2], int count, const double *plane)
{
    double next[PLANES + 8][2];
    int i, made = 0, edges = count == 2 ? 1 : count;
    for (i = 0; i < edges; i++) {
        const double *p = x[i], *q = x[i + 1 < count ? i + 1 : 0];
        const double a = plane[0] * p[0] + plane[1] * p[1] - plane[2];
        const double b = plane[0] * q[0] + plane[1] * q[1] - plane[2];
        if (a <= 0) {
            memcpy(next[made++], p, 2 * sizeof(double));
        }
        if ((a <= 0) != (b <= 0)) {
            next[made][0] = p[0] + a / (a - b) * (q[0] - p[0]);
            next[made++][1] = p[1] + a / (a - b) * (q[1] - p[1]);
        }
        if (count == 2 && b <= 0) {
            memcpy(next[made++], q, 2 * sizeof(double));
        }
    }
    memcpy(x, next, (size_t)made * sizeof *next);
    return made;
}

static double cut_area(const brute *b, double (*x)[2])
{
    double sum = 0;
    size_t f;
    int i, count = 3;
    for (f = 0; f < b->count && count > 0; f++) {
        count = cut(x, count, b->plane[f]);
    }
    for (i = 1; i + 1 < count; i++) {
        sum += (x[i][0] - x[0][0]) * (x[i + 1][1] - x[0][1]) - (x[i][1] - x[0][1]) * (x[i + 1][0] - x[0][0]);
    }
    return sum / 2;
}

static double cut_length(const brute *b, const double *p, const double *q)
{
    double x[PLANES + 8][2];
    size_t f;
    int count = 2;
    memcpy(x[0], p, 2 * sizeof(double));
    memcpy(x[1], q, 2 * sizeof(double));
    for (f = 0; f < b->count && count == 2; f++) {
        count = cut(x, count, b->plane[f]);
    }
    return count == 2 ? hypot(x[1][0] - x[0][0], x[1][1] - x[0][1]) : 0;
}

typedef struct sites { size_t count; double *x, *w, box[4]; const pbw_index *canonical; } sites;

static void brute_cell(const sites *s, size_t i, brute *b)
{
    size_t j;
    b->count = 0;
    for (j = 0; j < s->count; j++) {
        const double *p = s->x + 2 * i, *q = s->x + 2 * j, dx = q[0] - p[0], dy = q[1] - p[1];
        if (dx * dx + dy * dy > 0) {
            double *plane = b->plane[b->count];
            plane[0] = dx, plane[1] = dy;
            plane[2] = dx * p[0] + dy * p[1] + (dx * dx + dy * dy + (s->w != NULL ? s->w[i] - s->w[j] : 0)) / 2;
            b->name[b->count++] = (pbw_index)j;
        }
    }
}

static pbw_index wall(size_t edge)
{
    return (pbw_index)(PBW_NONE - 1 - edge);
}

static double area_to(const pbw_cells *cells, size_t i, pbw_index j)
{
    double area = 0;
    size_t f;
    for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
        area += cells->neighbors[f] == j ? cells->areas[f] : 0;
    }
    return area;
}

/* All areas and walls against brute force.  Returns the worst fault, relative to the size. */
static double brute_fault(const sites *s, const polygon *p, const pbw_cells *cells, double size, int aligned)
{
    const double origin[2] = { p->x[0] - 0.3711 * size, p->x[1] - 0.2177 * size };
    double sign[MOST_RINGS], worst = 0;
    size_t i, k;
    ring_signs(p, sign);
    for (i = 0; i < s->count; i++) {
        double area = 0;
        brute b;
        if (s->canonical[i] != i) {
            continue;
        }
        brute_cell(s, i, &b);
        for (k = 0; k < p->corners; k++) {
            const double *x = p->x + 2 * k, *y = end_of(p, k);
            double t[PLANES + 8][2];
            memcpy(t[0], origin, sizeof origin);
            memcpy(t[1], x, sizeof origin);
            memcpy(t[2], y, sizeof origin);
            area += sign[ring_of(p, k)] * cut_area(&b, t);
            if (!aligned) {                          /* along a side of cells a wall is of one of them */
                worst = fmax(worst, fabs(cut_length(&b, x, y) - area_to(cells, i, wall(k))) / size);
            }
        }
        worst = fmax(worst, fabs(area - cells->volumes[i]) / (size * size));
    }
    return worst;
}

/* ---- what holds for all */

static double sum_of(const pbw_cells *cells)
{
    double sum = 0, lost = 0;
    size_t i;
    for (i = 0; i < cells->cell_count; i++) {        /* Kahan's */
        const double x = cells->volumes[i] - lost, next = sum + x;
        lost = next - sum - x;
        sum = next;
    }
    return sum;
}

/* Facets of each cell join to loops around its area and centroid, and those between two cells have one length; a
   power cell may be a segment, of which the polygon has a part or none.  Returns the worst fault. */
static double shape_fault(const sites *s, const pbw_cells *cells, double size)
{
    double worst = 0;
    size_t i, f;
    for (i = 0; i < s->count; i++) {
        const double *site = s->x + 2 * i;
        double area = 0, moment[2] = { 0, 0 };
        pbw_index begin = PBW_NONE;
        for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
            const pbw_index *loop = cells->loops + cells->loop_first[f];
            const double *a = cells->vertices + 2 * (size_t)loop[0], *b = cells->vertices + 2 * (size_t)loop[1];
            const double ax = a[0] - site[0], ay = a[1] - site[1], bx = b[0] - site[0], by = b[1] - site[1];
            CHECK_EQUAL(cells->loop_first[f + 1] - cells->loop_first[f], 2);
            begin = begin == PBW_NONE ? loop[0] : begin;
            if (loop[1] == begin) {
                begin = PBW_NONE;                    /* closed */
            } else {
                CHECK(f + 1 < cells->first[i + 1] && cells->loops[cells->loop_first[f + 1]] == loop[1]);
            }
            area += (ax * by - ay * bx) / 2;
            moment[0] += (ax * by - ay * bx) * (ax + bx) / 6;
            moment[1] += (ax * by - ay * bx) * (ay + by) / 6;
            worst = fmax(worst, fabs(cells->areas[f] - hypot(bx - ax, by - ay)) / size);
            if (cells->neighbors[f] < s->count && cells->volumes[i] > 0
                && cells->volumes[cells->neighbors[f]] > 0) {
                worst = fmax(worst, fabs(area_to(cells, i, cells->neighbors[f])
                                         - area_to(cells, cells->neighbors[f], (pbw_index)i)) / size);
            }
        }
        CHECK(begin == PBW_NONE);
        worst = fmax(worst, fabs(area - cells->volumes[i]) / (size * size));
        for (f = 0; f < 2; f++) {
            const double arm = (cells->centroids[2 * i + f] - site[f]) * cells->volumes[i];
            worst = fmax(worst, fabs(moment[f] - arm) / (size * size * size));
        }
    }
    return worst;
}

/* The walls of all cells along each edge add up to it. */
static double wall_fault(const polygon *p, const pbw_cells *cells, double size)
{
    static double length[MOST_CORNERS];
    double worst = 0;
    size_t i;
    memset(length, 0, sizeof length);
    for (i = 0; i < cells->facet_count; i++) {
        if (PBW_NONE - 1 - cells->neighbors[i] < p->corners) {
            length[PBW_NONE - 1 - cells->neighbors[i]] += cells->areas[i];
        }
    }
    for (i = 0; i < p->corners; i++) {
        const double *a = p->x + 2 * i, *b = end_of(p, i);
        worst = fmax(worst, fabs(length[i] - hypot(b[0] - a[0], b[1] - a[1])) / size);
    }
    return worst;
}

static void *take(size_t bytes)
{
    return zoo_grow(NULL, bytes + 1);
}

static sites sites_make(int kind, size_t count, int weights)
{
    sites s;
    size_t i, k;
    s.count = count;
    s.x = (double *)take(count * 2 * sizeof(double));
    s.w = weights != INPUT_WEIGHTS_ZERO ? (double *)take(count * sizeof(double)) : NULL;
    input_fill(kind, 2, count, test_seed, s.x);
    if (s.w != NULL) {
        input_fill_weights(weights, 2, count, test_seed, s.x, s.w);
    }
    for (k = 0; k < 2; k++) {
        s.box[k] = s.box[2 + k] = s.x[k];
        for (i = 0; i < count; i++) {
            s.box[k] = fmin(s.box[k], s.x[2 * i + k]);
            s.box[2 + k] = fmax(s.box[2 + k], s.x[2 * i + k]);
        }
    }
    return s;
}

static void sites_free(sites *s)
{
    free(s->x);
    free(s->w);
}

/* Counts, sums and shapes; with few sites each cell. */
static void test_polygon(sites *s, polygon *p, int aligned, const char *name)
{
    if (test_begin("%s", name)) {
        const double size = fmax(fmax(s->box[2] - s->box[0], s->box[3] - s->box[1]), 1e-9);
        double whole, sum, shape, cell = 0;
        pbw_domain domain = domain_of(p);
        pbw_mesh mesh;
        pbw_cells cells, merged;
        pbw_status status;
        CHECK_EQUAL(pbw_triangulate(2, s->x, s->w, s->count, NULL, &mesh), PBW_OK);
        status = pbw_cells_of(&mesh, &domain, ALL, NULL, &cells);
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, ALL | PBW_CELLS_MERGE, NULL, &merged), status);
        CHECK_EQUAL(status, PBW_OK);
        s->canonical = mesh.canonical;
        whole = area_of(p);
        sum = fabs(sum_of(&cells) - whole) / whole;
        if (cells.first != NULL && merged.first != NULL) {
            shape = fmax(shape_fault(s, &cells, size), shape_fault(s, &merged, size));
            shape = fmax(shape, fmax(wall_fault(p, &cells, size), wall_fault(p, &merged, size)));
            cell = s->count < PLANES ? brute_fault(s, p, &cells, size, aligned) : 0;
            if (!CHECK(sum < 1e-12) || !CHECK(shape < 1e-12) || !CHECK(cell < 1e-12)) {
                test_say("sum %g, shapes %g, brute force %g", sum, shape, cell);
            }
        }
        pbw_cells_free(&cells);
        pbw_cells_free(&merged);
        pbw_free(&mesh);
        test_end();
    }
}

static void test_polygons(void)
{
    static const int weights[3] = { INPUT_WEIGHTS_ZERO, INPUT_WEIGHTS_HIDING, INPUT_WEIGHTS_HALF };
    static const int kinds[5] = { INPUT_UNIFORM, INPUT_CLUSTERS, INPUT_LATTICE, INPUT_SPHERE, INPUT_GAUSS };
    static const double margins[3] = { -0.2, 0, 1.5 };
    static polygon p;
    uint64_t state = test_seed;
    char name[120];
    int kind, shape, w, m, many;
    for (shape = 0; shape < POLYGONS; shape++) {
        for (kind = 0; kind < 5; kind++) {
            for (w = 0; w < (kind < 3 ? 3 : 1); w++) {
                for (m = 0; m < 3; m++) {
                    for (many = 0; many < 2; many++) {
                        sites s = sites_make(kinds[kind], many ? TEST_SIZE(3000) : 64, weights[w]);
                        polygon_make(&p, shape, &state);
                        polygon_fit(&p, s.box, margins[m]);
                        snprintf(name, sizeof name, "%s: %d %s, weights %s, margin %g", polygon_names[shape],
                                 (int)s.count, input_name(kinds[kind]), input_weights_name(weights[w]), margins[m]);
                        test_polygon(&s, &p, kinds[kind] == INPUT_LATTICE, name);
                        sites_free(&s);
                    }
                }
            }
        }
    }
}

/* ---- random polygons and points on a small grid: edges along sides, through corners of cells, through points */

/* Between a lower and an upper chain; sometimes with a square hole, never touching. */
static void make_monotone(polygon *p, uint64_t *state)
{
    enum { STEPS = 7 };
    int low[STEPS], high[STEPS], i, count = 2 + (int)input_below(state, STEPS - 1);
    polygon_start(p);
    for (i = 0; i < count; i++) {
        low[i] = (int)input_below(state, 4);
        high[i] = low[i] + 1 + (int)input_below(state, 5);
        add(p, i, low[i]);
    }
    for (i = count; i-- > 0; ) {
        add(p, i, high[i]);
    }
    close_ring(p);
    if (count > 2 && low[0] < 2 && low[1] < 2 && high[0] > 3 && high[1] > 3) {
        add(p, 0.5, 2.5), add(p, 0.75, 2.5), add(p, 0.75, 2.75), add(p, 0.5, 2.75);
        close_ring(p);
    }
}

static void test_grid(void)
{
    static polygon p;
    long i;
    if (test_begin("random polygons on a grid")) {
        for (i = 0; i < test_count; i++) {
            uint64_t state = test_seed * 1000003 + (uint64_t)i;
            double x[2 * 24], w[24], fault;
            pbw_domain domain;
            pbw_mesh mesh;
            pbw_cells cells;
            sites s;
            size_t k;
            make_monotone(&p, &state);
            memset(&s, 0, sizeof s);
            s.count = 3 + input_below(&state, 22);
            s.x = x;
            s.w = i % 3 == 0 ? w : NULL;
            for (k = 0; k < 2 * s.count; k++) {      /* halves */
                x[k] = input_below(&state, 15) / 2.0 - 0.5;
                w[k / 2] = input_below(&state, 3) / 2.0;
            }
            if (pbw_triangulate(2, x, s.w, s.count, NULL, &mesh) == PBW_OK) {
                const pbw_status status = pbw_cells_of(&mesh, (domain = domain_of(&p), &domain),
                                                       i % 2 != 0 ? ALL : ALL | PBW_CELLS_MERGE, NULL, &cells);
                s.canonical = mesh.canonical;
                fault = status != PBW_OK ? 1 : fmax(fabs(sum_of(&cells) - area_of(&p)), wall_fault(&p, &cells, 1));
                fault = status != PBW_OK ? 1 : fmax(fault, shape_fault(&s, &cells, 1));
                fault = status != PBW_OK ? 1 : fmax(fault, brute_fault(&s, &p, &cells, 1, 1));
                if (!CHECK(fault < 1e-12)) {
                    test_say("case %ld: status %d, fault %g", i, (int)status, fault);
                }
                pbw_cells_free(&cells);
            }
            pbw_free(&mesh);
        }
        test_end();
    }
}

/* ---- neighbours that share edges or parts of them, touch in corners, have spikes; rings without area */

enum { TILES = 6 };

/* Some squares of a grid, side by side as rectangles of height 1; flat: spikes and flat rings, too. */
static void make_tiles(polygon *p, int flat, unsigned char tiles[TILES][TILES], uint64_t *state)
{
    int x, y, from;
    polygon_start(p);
    for (y = 0; y < TILES; y++) {
        for (x = 0; x < TILES; x++) {
            tiles[y][x] = input_below(state, 5) < 3;
        }
        for (x = 0; x < TILES; ) {
            for (from = x; x < TILES && tiles[y][x] && (x == from || input_below(state, 2) == 0); x++) {
            }
            if (x == from) {
                x++;
                continue;
            }
            add(p, from, y), add(p, x, y), add(p, x, y + 1);
            if (flat && input_below(state, 3) == 0) {
                add(p, x + (int)input_below(state, 2), y + 2), add(p, x, y + 1);
                p->x[2 * p->corners - 4] = input_below(state, 2) != 0 ? x : p->x[2 * p->corners - 4];
                p->x[2 * p->corners - 3] = p->x[2 * p->corners - 4] > x ? y + 1 : y + 2;
            }
            add(p, from, y + 1);
            if (input_below(state, 2) != 0) {        /* the same place twice */
                add(p, from, y + 1);
            }
            close_ring(p);
        }
        if (flat && y % 2 != 0) {
            add(p, 1, y), add(p, 4, y), add(p, 3, y);
            close_ring(p);
        }
    }
    add_box(p, -2, 0, -1, 1);                        /* not nothing, whatever comes */
}

/* The volumes in the tiles and the square beside them, one by one. */
static void sum_tiles(const pbw_mesh *mesh, unsigned char tiles[TILES][TILES], double *volumes)
{
    pbw_domain domain;
    pbw_cells cells;
    int x, y;
    size_t i;
    memset(volumes, 0, mesh->point_count * sizeof *volumes);
    memset(&domain, 0, sizeof domain);
    for (y = 0; y < TILES; y++) {
        for (x = -2; x < TILES; x++) {
            double box[4];
            if (x < 0 ? x > -2 || y > 0 : !tiles[y][x]) {
                continue;
            }
            box[0] = x, box[1] = y, box[2] = x + 1, box[3] = y + 1;
            domain.box = box;
            CHECK_EQUAL(pbw_cells_of(mesh, &domain, 0, NULL, &cells), PBW_OK);
            for (i = 0; i < cells.cell_count; i++) {
                volumes[i] += cells.volumes[i];
            }
            pbw_cells_free(&cells);
        }
    }
}

static void test_tiles(void)
{
    static polygon p;
    int k, flat;
    for (flat = 0; flat < 2; flat++) {
        if (test_begin("neighbours that share edges%s", flat ? ", spikes, flat rings" : "")) {
            for (k = 0; k < TEST_SIZE(150); k++) {
                uint64_t state = test_seed * 1000033 + (uint64_t)k;
                unsigned char tiles[TILES][TILES];
                double x[2 * 24], w[24], volumes[24], sum = 0;
                pbw_domain domain;
                pbw_mesh mesh;
                pbw_cells cells;
                pbw_rings found;
                pbw_status status;
                sites s;
                size_t i;
                make_tiles(&p, flat, tiles, &state);
                domain = domain_of(&p);
                memset(&s, 0, sizeof s);
                s.count = 3 + input_below(&state, 22);
                s.x = x;
                s.w = k % 3 == 0 ? w : NULL;
                for (i = 0; i < 2 * s.count; i++) {  /* halves */
                    x[i] = input_below(&state, 15) / 2.0 - 0.5;
                    w[i / 2] = input_below(&state, 3) / 2.0;
                }
                status = pbw_triangulate(2, x, s.w, s.count, NULL, &mesh);
                CHECK(status == PBW_OK || status == PBW_DEGENERATE);
                s.canonical = mesh.canonical;
                sum_tiles(&mesh, tiles, volumes);
                status = pbw_cells_of(&mesh, &domain, k % 2 != 0 ? ALL : ALL | PBW_CELLS_MERGE, NULL, &cells);
                CHECK_EQUAL(status, PBW_OK);
                for (i = 0; i < cells.cell_count; i++) {
                    CHECK(fabs(cells.volumes[i] - volumes[i]) < 1e-12);
                    sum += volumes[i];
                }
                CHECK_EQUAL(pbw_cells_rings(&domain, NULL, &found), PBW_OK);
                if (cells.first != NULL && (!CHECK(shape_fault(&s, &cells, 1) < 1e-12)
                                            || !CHECK(fabs(found.area - sum) < 1e-12))) {
                    test_say("case %d: area %g, %g", k, found.area, sum);
                }
                pbw_cells_free(&cells);
                pbw_free(&mesh);
            }
            test_end();
        }
    }
}

/* Triangles around one corner, in some of the sectors between 16 directions. */
static void make_fan(polygon *p, uint64_t *state)
{
    static const int ray[17][2] = { { 2, 0 }, { 4, 2 }, { 2, 2 }, { 2, 4 }, { 0, 2 }, { -2, 4 }, { -2, 2 }, { -4, 2 },
                                    { -2, 0 }, { -4, -2 }, { -2, -2 }, { -2, -4 }, { 0, -2 }, { 2, -4 }, { 2, -2 },
                                    { 4, -2 }, { 2, 0 } };
    int k;
    polygon_start(p);
    for (k = 0; k < 16; k++) {
        const int a = 1 + (int)input_below(state, 2), b = 1 + (int)input_below(state, 2);
        if (input_below(state, 2) != 0 || (k == 15 && p->rings == 0)) {
            add(p, 3, 3);
            add(p, 3 + a * ray[k][0], 3 + a * ray[k][1]);
            add(p, 3 + b * ray[k + 1][0], 3 + b * ray[k + 1][1]);
            close_ring(p);
        }
    }
}

static void test_fans(void)
{
    static polygon p;
    int k;
    if (test_begin("parts that touch in a corner where cells meet")) {
        for (k = 0; k < TEST_SIZE(300); k++) {
            uint64_t state = test_seed * 1000037 + (uint64_t)k;
            double x[2 * 24], volumes[24];
            const size_t first[2] = { 0, 3 };
            pbw_domain domain;
            pbw_mesh mesh;
            pbw_cells cells;
            pbw_status status;
            sites s;
            size_t i, r;
            make_fan(&p, &state);
            memset(volumes, 0, sizeof volumes);
            memset(&s, 0, sizeof s);
            s.count = 2 + input_below(&state, 23);
            s.x = x;
            for (i = 0; i < 2 * s.count; i++) {
                x[i] = input_below(&state, 7);
            }
            status = pbw_triangulate(2, x, NULL, s.count, NULL, &mesh);
            CHECK(status == PBW_OK || status == PBW_DEGENERATE);
            s.canonical = mesh.canonical;
            for (r = 0; r < p.rings; r++) {
                domain = domain_of(&p);
                domain.rings = p.x + 2 * p.first[r];
                domain.ring_first = first;
                domain.ring_count = 1;
                CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_OK);
                for (i = 0; i < cells.cell_count; i++) {
                    volumes[i] += cells.volumes[i];
                }
                pbw_cells_free(&cells);
            }
            domain = domain_of(&p);
            CHECK_EQUAL(pbw_cells_of(&mesh, &domain, k % 2 != 0 ? ALL : ALL | PBW_CELLS_MERGE, NULL, &cells), PBW_OK);
            for (i = 0; i < cells.cell_count; i++) {
                CHECK(fabs(cells.volumes[i] - volumes[i]) < 1e-12);
            }
            CHECK(cells.first != NULL && shape_fault(&s, &cells, 1) < 1e-12);
            pbw_cells_free(&cells);
            pbw_free(&mesh);
        }
        test_end();
    }
}

/* Where rings cross, and what has no area. */
static void test_crossings(void)
{
    if (test_begin("crossings, and rings that enclose nothing")) {
        static polygon p;
        pbw_domain domain;
        pbw_rings found;
        size_t i;
        polygon_start(&p);
        add_box(&p, 0, 0, 2, 2);
        add_box(&p, 1, 1, 5, 4);                     /* overlap */
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_cells_rings(&domain, NULL, &found), PBW_ERROR_ARGUMENT);
        CHECK((found.edges[0] == 1 && found.edges[1] == 4) || (found.edges[0] == 2 && found.edges[1] == 7));
        CHECK(fabs(found.place[0] + found.place[1] - 3) < 1e-14 && fabs(fabs(found.place[0] - 1.5) - 0.5) < 1e-14);
        polygon_start(&p);
        add_box(&p, 0, 0, 1, 1), add_box(&p, 1, 0, 2, 1), add_box(&p, 2, 0, 3, 1);
        add(&p, 5, 0), add(&p, 7, 2), add(&p, 7, 0), add(&p, 5, 2);          /* a bow tie */
        close_ring(&p);
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_cells_rings(&domain, NULL, &found), PBW_ERROR_ARGUMENT);
        CHECK_EQUAL(found.edges[0], 12);
        CHECK_EQUAL(found.edges[1], 14);
        CHECK(fabs(found.place[0] - 6) < 1e-14 && fabs(found.place[1] - 1) < 1e-14);
        p.x[2 * 13] = 6, p.x[2 * 13 + 1] = 1;        /* a ring through its own corner twice is none that crosses */
        p.x[2 * 14] = 7, p.x[2 * 14 + 1] = 2;
        add(&p, 7, 0), add(&p, 6, 1), add(&p, 5, 2);
        p.x[2 * 15] = 7, p.x[2 * 15 + 1] = 0;
        p.x[2 * 16] = 6, p.x[2 * 16 + 1] = 1;
        p.x[2 * 17] = 5, p.x[2 * 17 + 1] = 2;
        p.first[4] = p.corners = 18;
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_cells_rings(&domain, NULL, &found), PBW_OK);
        CHECK(fabs(found.area - 5) < 1e-14);
        polygon_start(&p);
        add_box(&p, 0, 0, 1, 1), add_box(&p, 0, 0, 1, 1);            /* cancel */
        add(&p, 3, 3), add(&p, 4, 4), close_ring(&p);
        close_ring(&p);                              /* no corner */
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_cells_rings(&domain, NULL, &found), PBW_ERROR_ARGUMENT);
        CHECK(found.edges[0] == 0 && found.edges[1] == 0);
        polygon_start(&p);
        for (i = 0; i < 1000; i++) {                 /* a comb of long teeth, all of which overlap in x and in y */
            add(&p, (double)i, (double)i), add(&p, 4000 + (double)i + 0.5, -4000 + (double)i + 0.5);
        }
        add(&p, 9000, 5000), add(&p, -1, 9000);
        close_ring(&p);
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_cells_rings(&domain, NULL, &found), PBW_OK);
        CHECK(fabs(found.area - area_of(&p)) < 1e-12 * found.area);
        test_end();
    }
}

/* ---- polygons along the sides of a lattice's cells */

/* The facets and the corners of a cell, and how many of its facets are walls. */
static void count_facets(const pbw_cells *cells, size_t i, int *facets, int *walls)
{
    size_t f;
    *facets = *walls = 0;
    for (f = cells->first[i]; f < cells->first[i + 1]; f++) {
        ++*facets;
        *walls += cells->neighbors[f] >= cells->cell_count;
    }
}

/* Points at 0..n-1 in both axes; a box from half to half, with a hole of 2 x 2 cells: each cell is a whole square. */
static void test_aligned(void)
{
    enum { N = 9 };
    if (test_begin("a polygon along sides of cells")) {
        static polygon p;
        double x[2 * N * N];
        pbw_domain domain;
        pbw_mesh mesh;
        pbw_cells cells;
        size_t i;
        for (i = 0; i < N * N; i++) {
            x[2 * i] = (double)(i % N);
            x[2 * i + 1] = (double)(i / N);
        }
        polygon_start(&p);
        add_box(&p, 0.5, 0.5, 7.5, 7.5);
        add_box(&p, 2.5, 3.5, 4.5, 5.5);
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_triangulate(2, x, NULL, N * N, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, ALL | PBW_CELLS_MERGE, NULL, &cells), PBW_OK);
        for (i = 0; i < N * N && cells.first != NULL; i++) {
            const int u = (int)(i % N), v = (int)(i / N);
            const int hole = u >= 3 && u <= 4 && v >= 4 && v <= 5;
            const int in = u > 0 && u < N - 1 && v > 0 && v < N - 1 && !hole;
            int facets, walls, expected = (u == 1) + (u == N - 2) + (v == 1) + (v == N - 2);
            expected += v >= 4 && v <= 5 && (u == 2 || u == 5);
            expected += u >= 3 && u <= 4 && (v == 3 || v == 6);
            count_facets(&cells, i, &facets, &walls);
            CHECK(fabs(cells.volumes[i] - in) < 1e-14);
            CHECK_EQUAL(facets, in ? 4 : 0);
            CHECK_EQUAL(walls, in ? expected : 0);
        }
        pbw_cells_free(&cells);
        pbw_free(&mesh);
        test_end();
    }
}

/* Far from the origin, and with coordinates that are not comparable: an error. */
static void test_range(void)
{
    if (test_begin("far from the origin, and out of range")) {
        static polygon p;
        uint64_t state = test_seed;
        sites s = sites_make(INPUT_UNIFORM, 500, INPUT_WEIGHTS_ZERO);
        pbw_domain domain;
        pbw_mesh mesh;
        pbw_cells cells;
        size_t i;
        polygon_start(&p);
        make_star(&p, 50, &state);
        for (i = 0; i < 2 * p.corners; i++) {
            p.x[i] = floor(p.x[i] * 65536) / 65536 + 1048576;
        }
        for (i = 0; i < 2 * s.count; i++) {
            s.x[i] = floor(s.x[i] * 65536) / 65536 + 1048576;
        }
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_triangulate(2, s.x, NULL, s.count, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, ALL, NULL, &cells), PBW_OK);
        CHECK(fabs(sum_of(&cells) / area_of(&p) - 1) < 1e-12);
        pbw_cells_free(&cells);
        p.x[7] = 1e-200;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, ALL, NULL, &cells), PBW_ERROR_ARGUMENT);
        p.x[7] = HUGE_VAL;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, ALL, NULL, &cells), PBW_ERROR_NOT_FINITE);
        pbw_free(&mesh);
        s.x[3] = 1e100;
        p.x[7] = 0;
        CHECK_EQUAL(pbw_triangulate(2, s.x, NULL, s.count, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, ALL, NULL, &cells), PBW_ERROR_ARGUMENT);
        pbw_free(&mesh);
        sites_free(&s);
        test_end();
    }
}

/* Rings that are no polygon: an answer of some kind or an error, nothing worse. */
static void test_arguments(void)
{
    if (test_begin("arguments, and rings that cross")) {
        static polygon p;
        uint64_t state = test_seed;
        sites s = sites_make(INPUT_UNIFORM, 300, INPUT_WEIGHTS_ZERO);
        const double box[6] = { 0, 0, 1, 1, 1, 1 };
        pbw_domain domain;
        pbw_mesh mesh;
        pbw_cells cells;
        int i, k, refused = 0;
        CHECK_EQUAL(pbw_triangulate(2, s.x, NULL, s.count, NULL, &mesh), PBW_OK);
        polygon_start(&p);
        add_box(&p, 0, 0, 1, 1);
        domain = domain_of(&p);
        domain.box = box;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain.box = NULL;
        domain.ring_first = NULL;
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        domain = domain_of(&p);
        domain.periodic = 1;
        CHECK_EQUAL(pbw_cells_periodic(2, s.x, NULL, s.count, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        p.first[1] = 2;                              /* two corners */
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        polygon_start(&p);
        add(&p, 0, 0), add(&p, 0.5, 0.5), add(&p, 1, 1);         /* no area */
        close_ring(&p);
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_ERROR_ARGUMENT);
        for (i = 0; i < 200; i++) {                  /* any corners: nearly all such rings cross themselves */
            polygon_start(&p);
            for (k = 0; k < 3 + i % 9; k++) {
                const double x = input_uniform(&state), y = input_uniform(&state);
                add(&p, i % 2 != 0 ? floor(8 * x) / 8 : x, i % 2 != 0 ? floor(8 * y) / 8 : y);
            }
            close_ring(&p);
            domain = domain_of(&p);
            refused += pbw_cells_of(&mesh, &domain, ALL, NULL, &cells) == PBW_ERROR_ARGUMENT;
            pbw_cells_free(&cells);
        }
        CHECK(refused > 0);
        pbw_free(&mesh);
        sites_free(&s);
        test_end();
    }
}

/* ---- threads, failures */

static int equal(const void *a, const void *b, size_t bytes)
{
    return bytes == 0 || memcmp(a, b, bytes) == 0;
}

static int same_cells(const pbw_cells *a, const pbw_cells *b)
{
    const size_t n = a->facet_count;
    return a->cell_count == b->cell_count && n == b->facet_count && a->vertex_count == b->vertex_count
           && equal(a->volumes, b->volumes, a->cell_count * sizeof(double))
           && equal(a->centroids, b->centroids, a->cell_count * 2 * sizeof(double))
           && equal(a->first, b->first, (a->cell_count + 1) * sizeof(size_t))
           && equal(a->neighbors, b->neighbors, n * sizeof(pbw_index))
           && equal(a->areas, b->areas, n * sizeof(double))
           && equal(a->vertices, b->vertices, a->vertex_count * 2 * sizeof(double))
           && equal(a->loop_first, b->loop_first, (n + 1) * sizeof(size_t))
           && equal(a->loops, b->loops, a->loop_first[n] * sizeof(pbw_index));
}

static void test_threads(int shape, int kind)
{
    if (test_begin("threads: %s, %s", polygon_names[shape], input_name(kind))) {
        static polygon p;
        static const int counts[3] = { 1, 4, 8 };
        uint64_t state = test_seed;
        sites s = sites_make(kind, 20000, INPUT_WEIGHTS_ZERO);
        pbw_domain domain;
        pbw_mesh mesh;
        pbw_cells cells[3];
        int i;
        polygon_make(&p, shape, &state);
        polygon_fit(&p, s.box, -0.01);
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_triangulate(2, s.x, s.w, s.count, NULL, &mesh), PBW_OK);
        for (i = 0; i < 3; i++) {
            pbw_options options;
            memset(&options, 0, sizeof options);
            options.threads = counts[i];
            CHECK_EQUAL(pbw_cells_of(&mesh, &domain, ALL, &options, cells + i), PBW_OK);
        }
        CHECK(same_cells(cells, cells + 1));
        CHECK(same_cells(cells, cells + 2));
        for (i = 0; i < 3; i++) {
            pbw_cells_free(cells + i);
        }
        pbw_free(&mesh);
        sites_free(&s);
        test_end();
    }
}

static int stop(void *user, pbw_stage stage, double done)
{
    (void)done;
    return stage == PBW_STAGE_WORK && --*(int *)user < 0;
}

static void test_failures(void)
{
    if (test_begin("failures")) {
        static polygon p;
        uint64_t state = test_seed;
        sites s = sites_make(INPUT_UNIFORM, 60, INPUT_WEIGHTS_ZERO);
        pbw_options options;
        pbw_domain domain;
        pbw_mesh mesh;
        pbw_cells cells;
        meter m;
        long k;
        int left = 0;
        pbw_status status = PBW_ERROR_MEMORY;
        memset(&options, 0, sizeof options);
        polygon_make(&p, HOLES, &state);
        polygon_fit(&p, s.box, -0.1);
        domain = domain_of(&p);
        CHECK_EQUAL(pbw_triangulate(2, s.x, NULL, s.count, NULL, &mesh), PBW_OK);
        options.threads = 1;
        options.resize = meter_resize;
        options.resize_user = &m;
        for (k = 1; status == PBW_ERROR_MEMORY && k < 100000; k++) {
            meter_start(&m, k, k % 2 != 0);
            status = pbw_cells_of(&mesh, &domain, ALL, &options, &cells);
            CHECK(status == PBW_OK || cells.memory == NULL);
            pbw_cells_free(&cells);
            CHECK(m.blocks == 0 && m.bytes == 0 && m.faults == 0);
        }
        CHECK_EQUAL(status, PBW_OK);
        CHECK(k > 40);
        meter_start(&m, 0, 0);
        options.progress = stop;
        options.progress_user = &left;
        for (k = 0, status = PBW_CANCELLED; status == PBW_CANCELLED && k < 1000; k++) {
            left = (int)k;
            status = pbw_cells_of(&mesh, &domain, ALL, &options, &cells);
            CHECK(status == PBW_OK || (status == PBW_CANCELLED && cells.memory == NULL));
            pbw_cells_free(&cells);
            CHECK(m.blocks == 0);
        }
        CHECK(status == PBW_OK && k > 5);
        pbw_free(&mesh);
        sites_free(&s);
        test_end();
    }
}

/* A triangle so flat that pairs of doubles do not resolve its centre: cells in a box and in the box as a polygon. */
static void test_flat(void)
{
    if (test_begin("a flat triangle")) {
        const double x[10] = { -0.99999999999999911, -8.8817841970012523e-16, -8.8817841970012523e-16, 0,
                               -1, 0.99999999999999911, 1.0000000000000009, 1.0000000000000009, 0, 0 };
        const double w[5] = { 0.99999999999999822, 7.8886090522101181e-31, 1.9999999999999982,
                              2.0000000000000036, 0 };
        const double box[4] = { -7, -3, 7, 4 };
        static polygon p;
        pbw_domain domain, other;
        pbw_mesh mesh;
        pbw_cells cells, clipped;
        size_t i;
        polygon_start(&p);
        add_box(&p, -7, -3, 7, 4);
        other = domain_of(&p);
        memset(&domain, 0, sizeof domain);
        domain.box = box;
        CHECK_EQUAL(pbw_triangulate(2, x, w, 5, NULL, &mesh), PBW_OK);
        CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_OK);
        CHECK_EQUAL(pbw_cells_of(&mesh, &other, 0, NULL, &clipped), PBW_OK);
        for (i = 0; i < cells.cell_count && i < clipped.cell_count; i++) {
            CHECK(fabs(cells.volumes[i] - clipped.volumes[i]) < 1e-12);
        }
        pbw_cells_free(&cells);
        pbw_cells_free(&clipped);
        pbw_free(&mesh);
        test_end();
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 2000);
    test_flat();
    test_polygons();
    test_grid();
    test_tiles();
    test_fans();
    test_crossings();
    test_aligned();
    test_range();
    test_arguments();
    test_threads(COMB, INPUT_UNIFORM);
    test_threads(STAR, INPUT_CLUSTERS);
    test_threads(POINTS_ON_EDGES, INPUT_LATTICE);
    test_failures();
    return test_finish();
}
