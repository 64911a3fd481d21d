/* test_fill_shapes.c: pbw_fill.h on made shapes: cells with shared walls, prisms over combs, rings and pinched areas,
   rotated, nested, touching and nearly touching boxes, far from the origin, and bad input.  Valid ones must
   be filled: positive tetrahedra whose links agree, the triangles as facets, the right volume; others have a status.
       make fuzz-fill COUNT=10000 */
#include "pbw_fill.h"
#include "meter.h"
#include "test.h"
#include <math.h>

enum { MOST_POINTS = 4000, MOST_TRIANGLES = 8000, GRID = 12 };

typedef struct shape {
    double points[3 * MOST_POINTS], volume;          /* volume: what must come out; below 0: not known */
    pbw_index triangles[3 * MOST_TRIANGLES];
    size_t count, triangle_count;
    int nested, may_refuse;                          /* 1: as doubles, its parts may meet; 2: any refusal */
    const char *name;
} shape;

static shape s;
static uint64_t state;

static unsigned below(unsigned n)
{
    state += 0x9e3779b97f4a7c15u;
    return (unsigned)(pbw_mix(state) % n);
}

static double between(double from, double to)
{
    return from + (to - from) * below(1u << 30) / (double)(1u << 30);
}

static size_t add_point(double x, double y, double z)
{
    double *p = s.points + 3 * s.count;
    p[0] = x, p[1] = y, p[2] = z;
    return s.count++;
}

static void add_triangle(size_t a, size_t b, size_t c)
{
    pbw_index *t = s.triangles + 3 * s.triangle_count++;
    t[0] = (pbw_index)a, t[1] = (pbw_index)b, t[2] = (pbw_index)c;
}

static void add_quad(size_t a, size_t b, size_t c, size_t d)
{
    const int turned = below(2) != 0;
    add_triangle(a, b, turned ? d : c);
    add_triangle(turned ? b : a, c, d);
}

/* A rotation, from three angles. */
static void rotate(double *p, const double angle[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        const double c = cos(angle[k]), t = sin(angle[k]), u = p[k], v = p[(k + 1) % 3];
        p[k] = c * u - t * v;
        p[(k + 1) % 3] = t * u + c * v;
    }
}

static void add_box(const double low[3], const double high[3], const double *angle)
{
    static const int sides[6][4] = { { 0, 1, 3, 2 }, { 4, 5, 7, 6 }, { 0, 1, 5, 4 }, { 2, 3, 7, 6 }, { 0, 2, 6, 4 },
                                     { 1, 3, 7, 5 } };
    const size_t first = s.count;
    size_t i;
    int k;
    for (i = 0; i < 8; i++) {
        double p[3];
        for (k = 0; k < 3; k++) {
            p[k] = (i >> k & 1 ? high[k] - low[k] : 0) - (angle != NULL ? (high[k] - low[k]) / 2 : 0);
        }
        if (angle != NULL) {
            rotate(p, angle);
        }
        for (k = 0; k < 3; k++) {
            p[k] += low[k] + (angle != NULL ? (high[k] - low[k]) / 2 : 0);
        }
        (void)add_point(p[0], p[1], p[2]);
    }
    for (i = 0; i < 6; i++) {
        add_quad(first + (size_t)sides[i][0], first + (size_t)sides[i][1], first + (size_t)sides[i][2],
                 first + (size_t)sides[i][3]);
    }
}

/* ---- shapes ---- */

/* Cells of a lattice, each wall once. */
static void make_cells(void)
{
    const size_t n[3] = { 1 + below(4), 1 + below(4), 1 + below(4) };
    const size_t step[3] = { 1, n[0] + 1, (n[0] + 1) * (n[1] + 1) };
    const double pitch[3] = { 1 + below(3), 1 + below(3), below(2) ? 1 : 0.1 };
    size_t i, j, k;
    int axis;
    for (k = 0; k <= n[2]; k++) {
        for (j = 0; j <= n[1]; j++) {
            for (i = 0; i <= n[0]; i++) {
                (void)add_point((double)i * pitch[0], (double)j * pitch[1], (double)k * pitch[2]);
            }
        }
    }
    for (axis = 0; axis < 3; axis++) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (k = 0; k <= n[axis]; k++) {
            for (j = 0; j < n[v]; j++) {
                for (i = 0; i < n[u]; i++) {
                    const size_t at = k * step[axis] + j * step[v] + i * step[u];
                    add_quad(at, at + step[u], at + step[u] + step[v], at + step[v]);
                }
            }
        }
    }
    s.volume = pitch[0] * pitch[1] * pitch[2] * (double)(n[0] * n[1] * n[2]);
    s.nested = 1;
    s.name = "cells";
}

/* A prism over squares of a grid: a comb, a spiral, or any of them, which may touch in corners. */
static void make_prism(void)
{
    const int kind = (int)below(3), n = 4 + (int)below(GRID - 4);
    const double shear = below(2) ? between(-1, 1) : 0, height = below(4) ? 1 : 1e-3;
    unsigned char full[GRID + 2][GRID + 2];
    size_t id[GRID + 2][GRID + 2][2];
    int i, j, k, cells = 0;
    memset(full, 0, sizeof full);
    for (i = 1; i <= n; i++) {
        for (j = 1; j <= n; j++) {
            const int ring = i < j ? (i < n + 1 - j ? i : n + 1 - j) : (j < n + 1 - i ? j : n + 1 - i);
            full[i][j] = (unsigned char)(kind == 0 ? j == 1 || i % 2 == 1          /* teeth */
                       : kind == 1 ? ring % 2 == 1 && !(j == ring + 1 && i == ring && ring > 1)
                       : below(5) < 3);
            cells += full[i][j];
        }
    }
    cells += !full[1][1];
    full[1][1] = 1;
    memset(id, 0xff, sizeof id);
    for (i = 1; i <= n; i++) {
        for (j = 1; j <= n; j++) {
            for (k = 0; full[i][j] && k < 8; k++) {
                const int x = i + (k & 1), y = j + (k >> 1 & 1), z = k >> 2;
                if (id[x][y][z] == (size_t)-1) {
                    id[x][y][z] = add_point(x + shear * z * height, y + shear * x, z * height);
                }
            }
        }
    }
    for (i = 1; i <= n + 1; i++) {
        for (j = 1; j <= n + 1; j++) {
            for (k = 0; k < 2 && full[i][j]; k++) {
                add_quad(id[i][j][k], id[i + 1][j][k], id[i + 1][j + 1][k], id[i][j + 1][k]);
            }
            if (full[i][j] != full[i - 1][j]) {
                add_quad(id[i][j][0], id[i][j + 1][0], id[i][j + 1][1], id[i][j][1]);
            }
            if (full[i][j] != full[i][j - 1]) {
                add_quad(id[i][j][0], id[i + 1][j][0], id[i + 1][j][1], id[i][j][1]);
            }
        }
    }
    s.volume = cells * height;
    s.nested = kind == 2;
    s.volume = kind == 2 ? -1 : s.volume;            /* squares around a gap that is closed by corners */
    s.name = kind == 0 ? "comb" : kind == 1 ? "rings" : "polyomino";
}

/* Boxes apart from each other, turned. */
static void make_boxes(void)
{
    const int n = 1 + (int)below(4);
    int i, k;
    s.volume = 0;
    for (i = 0; i < n * n; i++) {
        double low[3] = { 4.0 * (i % n), 4.0 * (double)(i / n), 0 }, high[3], angle[3], volume = 1;
        for (k = 0; k < 3; k++) {
            const double side = below(6) ? between(0.2, 2) : 0.001;
            low[k] += (2 - side) / 2;
            high[k] = low[k] + side;
            volume *= high[k] - low[k];
            angle[k] = between(0, 3);
        }
        s.volume += volume;
        add_box(low, high, angle);
    }
    s.name = "boxes";
}

/* Shells in shells, turned; all regions are kept, or every second one. */
static void make_nested(void)
{
    const int n = 2 + (int)below(4);
    double side = 1;
    int i;
    s.nested = (int)below(2);
    s.volume = 0;
    for (i = 0; i < n; i++, side *= 0.5) {
        const double low[3] = { -side, -side, -side }, high[3] = { side, side, side };
        const double angle[3] = { between(0, 3), between(0, 3), between(0, 3) };
        add_box(low, high, angle);
        s.volume += s.nested ? (i == 0 ? 8 : 0) : (i % 2 == 0 ? 8 : -8) * side * side * side;
    }
    s.name = "nested boxes";
}

/* Boxes that have a corner, an edge or a side in common, or nearly so. */
static void make_neighbours(void)
{
    static const double gaps[] = { 0, 0, 1e-15, 1e-12, 1e-9, 1e-6 };
    const double gap = gaps[below(6)];
    const int common = (int)below(3);
    const double low[3] = { 0, 0, 0 }, high[3] = { 1, 1, 1 };
    double next[3], end[3];
    size_t i;
    int k;
    add_box(low, high, NULL);
    for (k = 0; k < 3; k++) {
        next[k] = k <= common ? 1 + gap : 0;
        end[k] = next[k] + 1;
    }
    add_box(next, end, NULL);
    if (common == 0 && !(gap > 0)) {                 /* the side that both have: with the same diagonals */
        for (i = 0; i < 6; i++) {
            s.triangles[3 * 12 + 24 + i] = s.triangles[30 + i];      /* sides 4 and 5 of the boxes */
        }
    }
    s.may_refuse = gap > 0 && gap < 1e-8;
    s.volume = 2;
    s.name = "neighbours";
}

/* What is no surface. */
static void make_bad(void)
{
    static const double values[] = { 1e308, -1e308, 1e-300, 4.9e-324, 0, 1, 2, 0.5 };
    const int kind = (int)below(6);
    const size_t points = kind == 0 ? 3 : 3 + below(12), count = kind == 0 ? 1 : below(20);
    size_t i;
    for (i = 0; i < points; i++) {
        double p[3];
        int k;
        for (k = 0; k < 3; k++) {
            p[k] = kind < 3 ? values[below(8)] : kind == 3 ? below(4) : between(0, 1);
            p[k] = kind == 1 && below(9) == 0 ? (below(2) ? NAN : HUGE_VAL) : kind == 2 && k == 2 ? 1 : p[k];
        }
        (void)add_point(p[0], p[1], p[2]);
    }
    for (i = 0; i < count; i++) {
        const unsigned most = (unsigned)points + (kind == 5 && below(4) == 0 ? 2 : 0);
        add_triangle(below(most), below(most), below(most));
    }
    s.nested = (int)below(2);
    s.volume = -1;
    s.may_refuse = 2;
    s.name = "bad input";
}

/* Moves and scales the shape: the coordinates of many are no longer small numbers. */
static void place_shape(void)
{
    static const double scales[] = { 1, 1, 1, 1e-150, 1e100, 3 }, places[] = { 0, 0, 1e6, 0, 0, 1.0 / 3 };
    const unsigned how = below(6);
    size_t i;
    if (s.may_refuse == 2) {
        return;
    }
    if (how == 1 && s.may_refuse == 0) {             /* 10^15 away, in whole steps of 2^20 */
        for (i = 0; i < 3 * s.count; i++) {
            s.points[i] = 1e15 + floor(s.points[i] * 1048576 + 0.5) * 1024;
        }
        s.volume = -1;
        s.may_refuse = 1;
        return;
    }
    for (i = 0; i < 3 * s.count; i++) {
        s.points[i] = s.points[i] * scales[how] + places[how];
    }
    s.volume *= s.volume < 0 ? 1 : how == 3 ? -1 : pow(scales[how], 3);
    s.may_refuse |= how == 2 && s.volume < 0.1;
}

/* ---- what must hold ---- */

/* Adds the volume of a tetrahedron, and to `terms` that of its determinant's products. */
static void add_volume(const double *const p[4], double *volume, double *terms)
{
    double m[3][3], sum = 0;
    int i, k;
    for (i = 0; i < 3; i++) {
        for (k = 0; k < 3; k++) {
            m[i][k] = p[i + 1][k] - p[0][k];
        }
    }
    for (i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        sum += m[0][i] * (m[1][j] * m[2][l] - m[1][l] * m[2][j]);
        *terms += fabs(m[0][i]) * (fabs(m[1][j] * m[2][l]) + fabs(m[1][l] * m[2][j])) / 6;
    }
    *volume += sum / 6;
}

/* By how much the volume of `tets` tetrahedra may differ from the shape's; u = 2^-53.
   A product in add_volume is rounded 9 times at most, and the sum once for each tetrahedron.
   Makers and place_shape move a coordinate by 31 u of the largest one, M, at most: a rotation is three times 3 u of
   two terms, together at most sqrt(6) of half of the box's side, and that is no more than M; places of boxes take 7 u
   of M, place_shape takes 2 u.  Points that stay on edges may be 2^-42 of M away from the doubles next to them there.
   A triangle that moves by d along each axis changes the volume by d times the sum of its areas seen along the axes,
   at most; 1.1 is for areas that grow. */
static double volume_slack(int stay, double terms, size_t tets, double volume)
{
    const double u = ldexp(1, -53);
    double most = 0, area = 0;
    size_t i;
    int k;
    for (i = 0; i < 3 * s.count; i++) {
        most = fmax(most, fabs(s.points[i]));
    }
    for (i = 0; i < s.triangle_count; i++) {
        const double *a = s.points + 3 * (size_t)s.triangles[3 * i];
        const double *b = s.points + 3 * (size_t)s.triangles[3 * i + 1];
        const double *c = s.points + 3 * (size_t)s.triangles[3 * i + 2];
        for (k = 0; k < 3; k++) {
            const int p = (k + 1) % 3, q = (k + 2) % 3;
            area += fabs((b[p] - a[p]) * (c[q] - a[q]) - (b[q] - a[q]) * (c[p] - a[p])) / 2;
        }
    }
    return 9.1 * u * terms + 1.1 * u * (double)tets * volume
         + 1.1 * (31 * u + (stay ? u + ldexp(1, -42) : 0)) * most * area;
}

static const char *judge_tets(const pbw_tets *t, double *volume, double *terms)
{
    size_t i, j;
    unsigned k;
    *volume = *terms = 0;
    for (i = 0; i < t->tet_count; i++) {
        const pbw_index *c = t->corners + 4 * i;
        const double *p[4];
        for (k = 0; k < 4; k++) {
            const pbw_index next = t->neighbors[4 * i + k];
            size_t common = 0, back = 0;
            if (c[k] >= t->point_count || (next != PBW_NONE && next >= t->tet_count)) {
                return "a number is out of range";
            }
            for (j = 0; next != PBW_NONE && j < 16; j++) {
                common += j % 4 != k && c[j % 4] == t->corners[4 * (size_t)next + j / 4];
                back += j < 4 && t->neighbors[4 * (size_t)next + j] == i;
            }
            if (next != PBW_NONE && (common != 3 || back != 1)) {
                return "a link does not fit";
            }
            p[k] = t->points + 3 * (size_t)c[k];
        }
        if (pbw_orient3(p[0], p[1], p[2], p[3]) <= 0) {
            return "a tetrahedron is not positive";
        }
        add_volume(p, volume, terms);
    }
    return NULL;
}

/* Whether facet i is the triangle that it says. */
static int is_triangle(const pbw_filled *f, size_t i)
{
    int k, m, found = 0;
    for (k = 0; k < 3; k++) {
        const pbw_index o = f->tets.original[f->facets[3 * i + (size_t)k]];
        for (m = 0; m < 3 && o != PBW_NONE; m++) {
            const double *p = s.points + 3 * (size_t)o;
            const double *q = s.points + 3 * (size_t)s.triangles[3 * (size_t)f->facet_triangle[i] + (size_t)m];
            found |= (memcmp(p, q, 3 * sizeof *p) == 0) << m;
        }
    }
    return found == 7;
}

static const char *judge(const pbw_filled *f, const pbw_fill_report *r, const pbw_fill_options *how)
{
    double volume, terms;
    const char *wrong = judge_tets(&f->tets, &volume, &terms);
    size_t i;
    if (wrong != NULL) {
        return wrong;
    }
    if (s.volume >= 0 && fabs(volume - s.volume) > volume_slack(how->conforming || r->refusal != PBW_FILL_FILLED,
                                                                terms, f->tets.tet_count, s.volume)) {
        return "the volume is wrong";
    }
    if (!how->conforming && r->refusal == PBW_FILL_FILLED) {
        const size_t facets = f->facet_count + r->doubles + r->collapsed;
        if (s.may_refuse == 2 ? facets < s.triangle_count : facets != s.triangle_count) {
            return "facets are missing";
        }
        for (i = 0; i < f->facet_count && facets == s.triangle_count; i++) {  /* more: of points on it */
            if (!is_triangle(f, i)) {
                return "a facet is no triangle of the surface";
            }
        }
    }
    return NULL;
}

static int cancel_at(void *user, pbw_stage stage, double done)
{
    (void)stage;
    (void)done;
    return --*(long *)user <= 0;
}

/* One shape; now and then memory fails, or the caller cancels.  Returns what is wrong. */
static const char *try_shape(void)
{
    static void (*const makers[])(void) = { make_cells, make_prism, make_prism, make_boxes, make_nested,
                                            make_neighbours, make_bad };
    pbw_fill_input in;
    pbw_fill_options how;
    pbw_fill_report report;
    pbw_filled f;
    pbw_options options;
    meter memory;
    pbw_status status;
    const char *wrong = NULL;
    long left = below(8) == 0 ? (long)below(60) : 1L << 40;
    s.count = s.triangle_count = 0;
    s.nested = s.may_refuse = 0;
    makers[below(7)]();
    place_shape();
    memset(&in, 0, sizeof in);
    memset(&how, 0, sizeof how);
    memset(&options, 0, sizeof options);
    in.points = s.points, in.point_count = s.count;
    in.triangles = s.triangles, in.triangle_count = s.triangle_count;
    how.nested = s.nested;
    how.conforming = below(2) != 0;
    how.split_flat = below(2) != 0;
    how.ratio = below(4) == 0 ? between(1, 3) : 0;
    how.outside = s.may_refuse == 2 && below(3) == 0;
    meter_start(&memory, below(8) == 0 ? 1 + (long)below(400) : 0, 0);
    options.threads = 1;
    options.resize = meter_resize;
    options.resize_user = &memory;
    options.memory_limit = below(16) == 0 ? 1 + (size_t)below(2000000) : 0;
    options.progress = cancel_at;
    options.progress_user = &left;
    status = pbw_fill(&in, &how, &options, &f, &report);
    if (status == PBW_OK) {
        wrong = judge(&f, &report, &how);
    } else if (!(status == PBW_ERROR_MEMORY && (memory.refused > 0 || options.memory_limit > 0))
               && !(status == PBW_CANCELLED && left <= 0)
               && !(s.may_refuse == 2 && (status == PBW_DEGENERATE || status == PBW_ERROR_NOT_FINITE
                                          || status == PBW_ERROR_ARGUMENT || status == PBW_ERROR_TOO_LARGE))
               && !(s.may_refuse == 1 && status == PBW_DEGENERATE
                    && (report.refusal == PBW_FILL_CROSSING || report.refusal == PBW_FILL_FLAT))) {
        wrong = status == PBW_DEGENERATE ? pbw_fill_refusal(report.refusal) : pbw_status_string(status);
    }
    pbw_fill_free(&f);
    return wrong != NULL ? wrong : memory.blocks != 0 || memory.faults != 0 ? "memory is held" : NULL;
}

int main(int argc, char **argv)
{
    long i;
    test_start(argc, argv, 300);
    if (test_begin("%ld shapes, seed %llu", test_count, (unsigned long long)test_seed)) {
        for (i = 0; i < test_count; i++) {
            const char *wrong;
            state = ((test_seed + 6) << 32) + (uint64_t)i * 0x10001u;
            wrong = try_shape();
            if (!CHECK(wrong == NULL)) {
                test_say("shape %ld, %s: %s", i, s.name, wrong);
            }
        }
        test_end();
    }
    return test_finish();
}
