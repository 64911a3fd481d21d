/* surface.c: the parts of a surface, and where the faults of its edges are.
   In: triangles.  Out: lines of the report.  Points at one place are taken for one, the first of them. */
#include "program.h"

typedef struct part { size_t faces, open, crowded, turned; double volume; } part;

typedef struct surface {
    const pbwio_cloud *cloud;
    const pbw_surface_faults *faults;
    pbw_index *first;                                /* of each point: the first at its place */
    pbw_index *component, *loop;                     /* of each point: trees whose root stands for all */
    part *parts;                                     /* at the roots of components */
    size_t open, crowded, turned, loops, components, unused;
    double area, volume;
} surface;

typedef enum fault { OPEN, CROWDED, TURNED } fault;

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

static fault fault_of(const surface *f, size_t edge)
{
    const pbw_index faces = f->faults->edge_triangles[edge];
    return faces == 1 ? OPEN : faces == 2 ? TURNED : CROWDED;
}

/* Areas, volumes and numbers of faces, of all and by components. */
static void measure_parts(surface *f)
{
    const pbw_index *t = f->cloud->triangles;
    const double *origin = f->cloud->points + 3 * (size_t)t[0];
    size_t i, k;
    for (i = 0; i < f->cloud->triangle_count; i++, t += 3) {
        const double *p = f->cloud->points + 3 * (size_t)t[0], *q = f->cloud->points + 3 * (size_t)t[1];
        const double *r = f->cloud->points + 3 * (size_t)t[2];
        part *at = f->parts + root(f->component, f->first[t[0]]);
        double n[3], volume = 0;
        for (k = 0; k < 3; k++) {
            const size_t u = (k + 1) % 3, v = (k + 2) % 3;
            n[k] = (q[u] - p[u]) * (r[v] - p[v]) - (q[v] - p[v]) * (r[u] - p[u]);
            volume += (p[k] - origin[k]) * n[k] / 6;
        }
        at->volume += volume;
        f->volume += volume;
        f->area += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        f->components += at->faces++ == 0;
    }
}

static void count_faults(surface *f)
{
    const pbw_index *e = f->faults->edges;
    pbw_index last = PBW_NONE;
    size_t i;
    for (i = 0; i < f->faults->edge_count; i++) {
        const fault what = fault_of(f, i);
        part *at = f->parts + root(f->component, e[2 * i]);
        f->open += what == OPEN;
        at->open += what == OPEN;
        f->crowded += what == CROWDED;
        at->crowded += what == CROWDED;
        f->turned += what == TURNED;
        at->turned += what == TURNED;
        if (what == OPEN) {
            unite(f->loop, e[2 * i], e[2 * i + 1]);
        }
    }
    for (i = 0; i < f->faults->edge_count; i++) {    /* the root of a loop is its least point: an edge starts there */
        if (fault_of(f, i) == OPEN && root(f->loop, e[2 * i]) == e[2 * i] && e[2 * i] != last) {
            f->loops++;
            last = e[2 * i];
        }
    }
}

static int count_all(surface *f)
{
    const pbwio_cloud *c = f->cloud;
    unsigned char *used = (unsigned char *)calloc(c->count + 1, 1);
    size_t i;
    f->first = (pbw_index *)malloc(c->count * sizeof *f->first);
    f->component = (pbw_index *)malloc(c->count * sizeof *f->component);
    f->loop = (pbw_index *)malloc(c->count * sizeof *f->loop);
    f->parts = (part *)calloc(c->count, sizeof *f->parts);
    if (used == NULL || f->first == NULL || f->component == NULL || f->loop == NULL || f->parts == NULL) {
        free(used);
        return 0;
    }
    for (i = 0; i < c->count; i++) {
        f->first[i] = f->component[i] = f->loop[i] = (pbw_index)i;
    }
    for (i = 0; i < f->faults->repeated_count; i++) {
        f->first[f->faults->repeated[2 * i]] = f->faults->repeated[2 * i + 1];
    }
    for (i = 0; i < 3 * c->triangle_count; i++) {
        used[c->triangles[i]] = 1;
        if (i % 3 > 0) {
            unite(f->component, f->first[c->triangles[i - 1]], f->first[c->triangles[i]]);
        }
    }
    for (i = 0; i < c->count; i++) {
        f->unused += !used[i];
    }
    free(used);
    measure_parts(f);
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
    const pbw_index *e = f->faults->edges;
    size_t i, k, length, loops = 0;
    pbw_index last = PBW_NONE;
    report_line(j, "%zu open edge%s in %zu loop%s:", COUNT(f->open), COUNT(f->loops));
    for (i = 0; i < f->faults->edge_count && loops < MOST_SHOWN; i++) {
        pbw_index a = e[2 * i];
        char text[512] = "";
        const double *p = f->cloud->points + 3 * (size_t)a;
        if (fault_of(f, i) != OPEN || a == last || root(f->loop, a) != a) {
            continue;
        }
        last = a;
        for (k = i, length = 0; k < f->faults->edge_count; k++) {
            if (fault_of(f, k) == OPEN && root(f->loop, e[2 * k]) == a && length++ < MOST_SHOWN) {
                snprintf(text + strlen(text), sizeof text - strlen(text), " %lu-%lu", (unsigned long)e[2 * k],
                         (unsigned long)e[2 * k + 1]);
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

/* Appends the first faces of an edge to a text. */
static void name_faces(const surface *f, const pbw_index *edge, char *text, size_t size)
{
    const pbwio_cloud *c = f->cloud;
    size_t i, found = 0;
    for (i = 0; i < 3 * c->triangle_count && found <= 6; i++) {
        const pbw_index a = f->first[c->triangles[i]], b = f->first[c->triangles[i % 3 == 2 ? i - 2 : i + 1]];
        if ((a == edge[0] && b == edge[1]) || (a == edge[1] && b == edge[0])) {
            if (found++ < 6) {
                snprintf(text + strlen(text), size - strlen(text), " %zu", i / 3);
            } else {
                snprintf(text + strlen(text), size - strlen(text), " ...");
            }
        }
    }
}

static void list_edges(const job *j, const surface *f, fault what, size_t count, const char *name)
{
    size_t i, shown = 0;
    report_line(j, "%zu %s edge%s:", count, name, plural(count));
    for (i = 0; i < f->faults->edge_count && shown < MOST_SHOWN; i++) {
        const pbw_index *e = f->faults->edges + 2 * i;
        char text[256] = "";
        if (fault_of(f, i) == what) {
            name_faces(f, e, text, sizeof text);
            report_line(j, "  %lu-%lu: faces%s", (unsigned long)e[0], (unsigned long)e[1], text);
            shown++;
        }
    }
    if (shown < count) {
        report_line(j, "  and %zu more", count - shown);
    }
}

/* The lines of a surface that was looked through.  Returns whether it has an inside. */
static int describe_parts(const job *j, surface *f, int details, double start)
{
    const int closed = f->faults->edge_count == 0;
    report_step(j, "surface", now() - start, closed ? "closed, %zu component%s" : "not closed, %zu component%s",
                COUNT(f->components));
    if (closed) {
        report_line(j, "area %g, volume %g, %zu flat face%s, %zu unused and %zu duplicate point%s", f->area,
                    f->volume, COUNT(f->faults->flat_count), f->unused, COUNT(f->faults->repeated_count));
    } else {
        report_line(j, "area %g, no volume: %zu open, %zu crowded, %zu turned edge%s in %zu loop%s; %zu flat "
                    "face%s, %zu unused and %zu duplicate point%s", f->area, f->open, f->crowded,
                    COUNT(f->turned), COUNT(f->loops), COUNT(f->faults->flat_count), f->unused,
                    COUNT(f->faults->repeated_count));
    }
    if (details && (!closed || f->components > 1)) {
        list_components(j, f);
    }
    if (details && f->open > 0) {
        list_loops(j, f);
    }
    if (details && f->crowded > 0) {
        list_edges(j, f, CROWDED, f->crowded, "crowded");
    }
    if (details && f->turned > 0) {
        list_edges(j, f, TURNED, f->turned, "turned");
    }
    return closed;
}

int describe_faults(job *j, const pbwio_cloud *cloud, const pbw_surface_faults *faults, int details, double start)
{
    surface f;
    int closed = 0;
    memset(&f, 0, sizeof f);
    f.cloud = cloud;
    f.faults = faults;
    if (!count_all(&f)) {
        report_step(j, "surface", now() - start, "out of memory");
    } else if (!(f.area > 0) || !(f.area <= DBL_MAX)) {
        report_step(j, "surface", now() - start, "%s",
                    pbwsample_status_string(f.area > 0 ? PBW_ERROR_NOT_FINITE : PBW_DEGENERATE));
    } else {
        closed = describe_parts(j, &f, details, start);
    }
    free(f.first);
    free(f.component);
    free(f.loop);
    free(f.parts);
    return closed;
}

int describe_surface(job *j, const pbwio_cloud *cloud, int details)
{
    pbw_surface_faults faults;
    pbw_status status;
    const double start = now();
    int closed = 0;
    begin(j, "surface", "");
    j->stage = "surface";
    status = pbw_surface_crossings(cloud->points, cloud->count, cloud->triangles, cloud->triangle_count, &j->build,
                                   &faults);
    j->stage = NULL;
    if (status == PBW_OK) {
        closed = describe_faults(j, cloud, &faults, details, start);
    } else {
        report_step(j, "surface", now() - start, "%s", pbw_status_string(status));
    }
    pbw_surface_faults_free(&faults);
    return closed;
}
