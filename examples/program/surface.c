/* surface.c: where the faults of a surface are.
   In: triangles.  Out: lines of the report.  Points at one place are taken for one, the first of them. */
#include "program.h"

typedef struct place { double x[3]; pbw_index id; } place;
typedef struct side { pbw_index a, b, face; int back; } side;          /* a < b; back: the face runs from b to a */
typedef struct part { size_t faces, open, crowded, turned; double volume; } part;

typedef struct surface {
    const pbwio_cloud *cloud;
    pbw_index *first;                                /* of each point: the first at its place */
    side *sides;                                     /* sorted: the sides of an edge follow each other */
    size_t side_count;
    pbw_index *component, *loop;                     /* of each point: trees whose root stands for all */
    part *parts;                                     /* at the roots of components */
    size_t open, crowded, turned, loops, components;
} surface;

typedef enum fault { NONE, OPEN, CROWDED, TURNED } fault;

static int by_place(const void *a, const void *b)
{
    const place *p = (const place *)a, *q = (const place *)b;
    int k;
    for (k = 0; k < 3; k++) {
        if (p->x[k] < q->x[k] || p->x[k] > q->x[k]) {
            return p->x[k] < q->x[k] ? -1 : 1;
        }
    }
    return p->id < q->id ? -1 : p->id > q->id;
}

static int by_edge(const void *a, const void *b)
{
    const side *p = (const side *)a, *q = (const side *)b;
    return p->a != q->a ? (p->a < q->a ? -1 : 1) : p->b != q->b ? (p->b < q->b ? -1 : 1)
         : p->face < q->face ? -1 : p->face > q->face;
}

static pbw_index root(pbw_index *tree, pbw_index i)
{
    while (tree[i] != i) {
        i = tree[i] = tree[tree[i]];
    }
    return i;
}

static void unite(pbw_index *tree, pbw_index a, pbw_index b)         /* the least number becomes the root */
{
    a = root(tree, a);
    b = root(tree, b);
    tree[a < b ? b : a] = a < b ? a : b;
}

static int weld(surface *f)
{
    size_t i, count = f->cloud->count;
    place *places = (place *)malloc(count * sizeof *places);
    if (places == NULL) {
        return 0;
    }
    for (i = 0; i < count; i++) {
        memcpy(places[i].x, f->cloud->points + 3 * i, sizeof places[i].x);
        places[i].id = (pbw_index)i;
    }
    qsort(places, count, sizeof *places, by_place);
    for (i = 0; i < count; i++) {
        int again = i > 0 && places[i].x[0] <= places[i - 1].x[0] && places[i].x[1] <= places[i - 1].x[1]
                 && places[i].x[2] <= places[i - 1].x[2];
        f->first[places[i].id] = again ? f->first[places[i - 1].id] : places[i].id;
    }
    free(places);
    return 1;
}

/* The fault of the edge whose sides start at i; *end: where the next edge starts. */
static fault fault_of(const surface *f, size_t i, size_t *end)
{
    size_t n = i;
    int back = 0;
    for (; n < f->side_count && f->sides[n].a == f->sides[i].a && f->sides[n].b == f->sides[i].b; n++) {
        back += f->sides[n].back;
    }
    *end = n;
    return n - i == 1 ? OPEN : n - i > 2 ? CROWDED : back != 1 ? TURNED : NONE;
}

static void count_faults(surface *f)
{
    const pbw_index *t = f->cloud->triangles;
    const double *origin = f->cloud->points + 3 * (size_t)t[0];
    size_t i, k, end;
    pbw_index last = PBW_NONE;
    for (i = 0; i < f->cloud->triangle_count; i++, t += 3) {
        const double *p = f->cloud->points + 3 * (size_t)t[0], *q = f->cloud->points + 3 * (size_t)t[1];
        const double *r = f->cloud->points + 3 * (size_t)t[2];
        part *at = f->parts + root(f->component, f->first[t[0]]);
        double n[3];
        for (k = 0; k < 3; k++) {
            size_t u = (k + 1) % 3, v = (k + 2) % 3;
            n[k] = (q[u] - p[u]) * (r[v] - p[v]) - (q[v] - p[v]) * (r[u] - p[u]);
            at->volume += (p[k] - origin[k]) * n[k] / 6;
        }
        f->components += at->faces++ == 0;
    }
    for (i = 0; i < f->side_count; i = end) {
        fault what = fault_of(f, i, &end);
        part *at = f->parts + root(f->component, f->sides[i].a);
        f->open += what == OPEN;
        at->open += what == OPEN;
        f->crowded += what == CROWDED;
        at->crowded += what == CROWDED;
        f->turned += what == TURNED;
        at->turned += what == TURNED;
        if (what == OPEN) {
            unite(f->loop, f->sides[i].a, f->sides[i].b);
        }
    }
    for (i = 0; i < f->side_count; i = end) {        /* the root of a loop is its least point: an edge starts there */
        pbw_index a = f->sides[i].a;
        if (fault_of(f, i, &end) == OPEN && root(f->loop, a) == a && a != last) {
            f->loops++;
            last = a;
        }
    }
}

static int find_faults(surface *f)
{
    const pbwio_cloud *c = f->cloud;
    size_t i, k;
    f->first = (pbw_index *)malloc(c->count * sizeof *f->first);
    f->component = (pbw_index *)malloc(c->count * sizeof *f->component);
    f->loop = (pbw_index *)malloc(c->count * sizeof *f->loop);
    f->parts = (part *)calloc(c->count, sizeof *f->parts);
    f->sides = (side *)malloc(3 * c->triangle_count * sizeof *f->sides);
    if (f->first == NULL || f->component == NULL || f->loop == NULL || f->parts == NULL || f->sides == NULL
        || !weld(f)) {
        return 0;
    }
    for (i = 0; i < c->count; i++) {
        f->component[i] = f->loop[i] = (pbw_index)i;
    }
    for (i = 0; i < 3 * c->triangle_count; i++) {
        k = i % 3 == 2 ? i - 2 : i + 1;
        if (f->first[c->triangles[i]] != f->first[c->triangles[k]]) {
            side *e = f->sides + f->side_count++;
            pbw_index a = f->first[c->triangles[i]], b = f->first[c->triangles[k]];
            e->a = a < b ? a : b;
            e->b = a < b ? b : a;
            e->face = (pbw_index)(i / 3);
            e->back = a > b;
            unite(f->component, a, b);
        }
    }
    qsort(f->sides, f->side_count, sizeof *f->sides, by_edge);
    count_faults(f);
    return 1;
}

/* ---- the report ---- */

static void list_components(const job *j, const surface *f)
{
    size_t i, shown = 0;
    report_line(j, "%zu component%s:", COUNT(f->components));
    for (i = 0; i < f->cloud->count && shown < MOST_SHOWN; i++) {
        const part *at = f->parts + i;
        if (at->faces == 0) {
            continue;
        }
        shown++;
        if (at->open + at->crowded + at->turned == 0) {
            report_line(j, "  with point %zu: %zu face%s, closed, volume %g", i, COUNT(at->faces), at->volume);
        } else {
            report_line(j, "  with point %zu: %zu face%s, %zu open, %zu crowded, %zu turned edge%s", i,
                        COUNT(at->faces), at->open, at->crowded, COUNT(at->turned));
        }
    }
    if (shown < f->components) {
        report_line(j, "  and %zu more", f->components - shown);
    }
}

/* Open edges, loop by loop. */
static void list_loops(const job *j, surface *f)
{
    size_t i, k, end, next, length, loops = 0;
    pbw_index last = PBW_NONE;
    report_line(j, "%zu open edge%s in %zu loop%s:", COUNT(f->open), COUNT(f->loops));
    for (i = 0; i < f->side_count && loops < MOST_SHOWN; i = end) {
        pbw_index a = f->sides[i].a;
        char text[512] = "";
        const double *p = f->cloud->points + 3 * (size_t)a;
        if (fault_of(f, i, &end) != OPEN || a == last || root(f->loop, a) != a) {
            continue;
        }
        last = a;
        for (k = i, length = 0; k < f->side_count; k = next) {
            if (fault_of(f, k, &next) == OPEN && root(f->loop, f->sides[k].a) == a && length++ < MOST_SHOWN) {
                snprintf(text + strlen(text), sizeof text - strlen(text), " %lu-%lu", (unsigned long)f->sides[k].a,
                         (unsigned long)f->sides[k].b);
            }
        }
        report_line(j, "  %zu edge%s from (%g, %g, %g):%s%s", COUNT(length), p[0], p[1], p[2], text,
                    length > MOST_SHOWN ? " ..." : "");
        loops++;
    }
    if (loops < f->loops) {
        report_line(j, "  and %zu more", f->loops - loops);
    }
}

static void list_edges(const job *j, const surface *f, fault what, size_t count, const char *name)
{
    size_t i, k, end, shown = 0;
    report_line(j, "%zu %s edge%s:", count, name, plural(count));
    for (i = 0; i < f->side_count && shown < MOST_SHOWN; i = end) {
        char text[256] = "";
        if (fault_of(f, i, &end) != what) {
            continue;
        }
        for (k = i; k < end && k < i + 6; k++) {
            snprintf(text + strlen(text), sizeof text - strlen(text), " %lu", (unsigned long)f->sides[k].face);
        }
        report_line(j, "  %lu-%lu: faces%s%s", (unsigned long)f->sides[i].a, (unsigned long)f->sides[i].b, text,
                    k < end ? " ..." : "");
        shown++;
    }
    if (shown < count) {
        report_line(j, "  and %zu more", count - shown);
    }
}

int describe_surface(job *j, const pbwio_cloud *cloud, int details)
{
    surface f;
    pbwsample_model model = model_of(cloud);
    pbwsample_report report;
    pbw_status status;
    double start = now();
    int closed = 0, found;
    begin(j, "surface", "");
    memset(&f, 0, sizeof f);
    f.cloud = cloud;
    j->stage = "surface";
    status = pbwsample_inspect(&model, NULL, &report);
    j->stage = NULL;
    found = status == PBW_OK && find_faults(&f);
    if (status != PBW_OK) {
        report_step(j, "surface", now() - start, "%s", pbwsample_status_string(status));
    } else if (!found) {
        report_step(j, "surface", now() - start, "out of memory");
    } else {
        closed = report.closed;
        report_step(j, "surface", now() - start, closed ? "closed, %zu component%s" : "not closed, %zu component%s",
                    COUNT(f.components));
        if (closed) {
            report_line(j, "area %g, volume %g, %zu flat face%s, %zu unused and %zu duplicate point%s", report.area,
                        report.volume, COUNT(report.flat_triangles), report.unused_points,
                        COUNT(report.duplicate_points));
        } else {
            report_line(j, "area %g, no volume: %zu open, %zu crowded, %zu turned edge%s in %zu loop%s; %zu flat "
                        "face%s, %zu unused and %zu duplicate point%s", report.area, f.open, f.crowded,
                        COUNT(f.turned), COUNT(f.loops), COUNT(report.flat_triangles), report.unused_points,
                        COUNT(report.duplicate_points));
        }
        if (details && (!closed || f.components > 1)) {
            list_components(j, &f);
        }
        if (details && f.open > 0) {
            list_loops(j, &f);
        }
        if (details && f.crowded > 0) {
            list_edges(j, &f, CROWDED, f.crowded, "crowded");
        }
        if (details && f.turned > 0) {
            list_edges(j, &f, TURNED, f.turned, "turned");
        }
    }
    free(f.first);
    free(f.component);
    free(f.loop);
    free(f.parts);
    free(f.sides);
    return closed;
}
