/* domain.c: reads plane domains: .poly and .node as Triangle has them; .geojson by geojson.c.
   In: a file.  Out: points, segments, holes, regions and what they carry, or a message "name:line: what". */
#include "domain.h"
#include <errno.h>
#include <stdarg.h>

enum { MOST_ATTRIBUTES = 64 };                       /* of a point */

/* ---- growing arrays ---- */

int grow(void **data, size_t count, size_t size)
{
    void *more;
    if ((count & (count - 1)) != 0 && count > 0) {
        return 1;
    }
    more = realloc(*data, (count == 0 ? 1 : 2 * count) * size);
    *data = more != NULL ? more : *data;
    return more != NULL;
}

int append_point(plan *d, double x, double y)
{
    if (!grow((void **)&d->points, d->point_count, 2 * sizeof *d->points)) {
        return 0;
    }
    d->points[2 * d->point_count] = x;
    d->points[2 * d->point_count++ + 1] = y;
    return 1;
}

int append_segment(plan *d, size_t a, size_t b, source from)
{
    if (!grow((void **)&d->segments, d->segment_count, 2 * sizeof *d->segments)
        || !grow((void **)&d->sources, d->segment_count, sizeof *d->sources)) {
        return 0;
    }
    d->sources[d->segment_count] = from;
    d->segments[2 * d->segment_count] = (pbw_index)a;
    d->segments[2 * d->segment_count++ + 1] = (pbw_index)b;
    return 1;
}

/* ---- groups ---- */

static char *copy_of(const char *name)
{
    char *copy = (char *)malloc(strlen(name) + 1);
    return copy != NULL ? strcpy(copy, name) : NULL;
}

typedef struct item { label of; size_t number; } item;

static int compare_items(const void *one, const void *other)         /* those of nothing last, names after tags */
{
    const item *a = (const item *)one, *b = (const item *)other;
    if (a->of.is != b->of.is) {
        return a->of.is ? -1 : 1;
    }
    if (!a->of.is || (a->of.name != NULL) != (b->of.name != NULL)) {
        return !a->of.is ? 0 : a->of.name != NULL ? 1 : -1;
    }
    return a->of.name != NULL ? strcmp(a->of.name, b->of.name) : (a->of.tag > b->of.tag) - (a->of.tag < b->of.tag);
}

int make_groups(plan *d, const label *labels, size_t count, pbw_index **of)
{
    item *items = (item *)malloc((count + 1) * sizeof *items);
    long long most = 0;
    size_t i;
    int done = items != NULL;
    *of = (pbw_index *)malloc((count + 1) * sizeof **of);
    d->groups = (pbwio_group *)calloc(count + 1, sizeof *d->groups);
    done = done && *of != NULL && d->groups != NULL;
    for (i = 0; i < count && done; i++) {
        items[i].of = labels[i];
        items[i].number = i;
    }
    if (done) {
        qsort(items, count, sizeof *items, compare_items);
    }
    for (i = 0; i < count && done; i++) {
        const label *own = &items[i].of;
        pbwio_group *g = d->groups + d->group_count;
        (*of)[items[i].number] = PBW_NONE;
        if (!own->is) {
            continue;
        }
        if (i == 0 || compare_items(items + i - 1, items + i) != 0) {
            most = own->name == NULL && own->tag > most ? own->tag : most;
            g->dim = 2;
            g->tag = own->name != NULL ? ++most : own->tag;
            g->name = own->name != NULL ? copy_of(own->name) : NULL;
            d->group_count++;
            done = own->name == NULL || g->name != NULL;
        }
        (*of)[items[i].number] = (pbw_index)d->group_count - 1;
    }
    free(items);
    return done;
}

void domain_free(plan *d)
{
    size_t i;
    for (i = 0; i < d->group_count; i++) {
        free(d->groups[i].name);
    }
    for (i = 0; i < d->column_count; i++) {
        free(d->columns[i].name);
        free(d->columns[i].values);
    }
    free(d->points);
    free(d->segments);
    free(d->sources);
    free(d->point_markers);
    free(d->holes);
    free(d->sizes);
    free(d->heights);
    free(d->triangles);
    free(d->triangle_groups);
    free(d->segment_groups);
    free(d->point_groups);
    free(d->regions);
    free(d->region_groups);
    free(d->feature_groups);
    free(d->groups);
    free(d->columns);
    memset(d, 0, sizeof *d);
}

/* ---- text ---- */

int refuse(text *t, const char *format, ...)
{
    va_list list;
    int used;
    if (t->error[0] == 0) {
        used = snprintf(t->error, sizeof t->error, "%.100s:%zu: ", t->name, t->line);
        va_start(list, format);
        vsnprintf(t->error + used, sizeof t->error - (size_t)used, format, list);
        va_end(list);
    }
    return 0;
}

/* Reads a file whole, with a 0 behind it. */
static int open_text(text *t, const char *path, const pbw_options *build)
{
    pbwio_error error;
    size_t size;
    memset(t, 0, sizeof *t);
    t->name = path;
    t->build = build;
    t->line = 1;
    t->data = pbwio_load(path, build, &size, &error);
    if (t->data == NULL) {
        snprintf(t->error, sizeof t->error, "%.255s", error.text);
        return 0;
    }
    if (strlen(t->data) < size) {
        return refuse(t, "byte %zu is 0: UTF-8 text is needed", strlen(t->data));
    }
    t->at = t->data + (strncmp(t->data, "\xef\xbb\xbf", 3) == 0 ? 3 : 0);
    return 1;
}

int next_number(text *t, double *x)
{
    const size_t length = strspn(t->at, "+-.0123456789eE");
    char *end;
    *x = length > 0 ? strtod(t->at, &end) : 0;
    if (length == 0 || end != t->at + length || !(fabs(*x) <= DBL_MAX)) {
        return 0;
    }
    t->at = end;
    return 1;
}

/* ---- .poly and .node: numbers; # starts a comment ---- */

static void skip_blanks(text *t, int lines)
{
    for (;; t->at++) {
        if (*t->at == '#') {
            t->at += strcspn(t->at, "\n");
        }
        if (*t->at == '\n' && lines) {
            t->line++;
        } else if (*t->at == 0 || strchr(" \t\r,", *t->at) == NULL) {
            return;
        }
    }
}

/* The next number of the file, or of the line.  Returns whether there is one. */
static int number(text *t, int lines, double *x)
{
    skip_blanks(t, lines);
    return next_number(t, x);
}

static int count(text *t, const char *what, double *x)
{
    if (!number(t, 1, x) || !(*x >= 0 && *x <= 4e9) || *x > floor(*x)) {
        return refuse(t, "the number of %s is needed", what);
    }
    return 1;
}

/* The rest of a line: up to `most` numbers; returns how many there are, or -1: something else is there. */
static int rest(text *t, double *x, int most)
{
    int n = 0;
    double unused;
    while (number(t, 0, n < most ? x + n : &unused)) {
        n++;
    }
    return *t->at == '\n' || *t->at == 0 ? n : -1;
}

static int marker_of(text *t, double x, int *marker)
{
    if (!(x >= INT_MIN && x <= INT_MAX) || x > floor(x)) {
        return refuse(t, "the marker %g is no whole number of 32 bits", x);
    }
    *marker = (int)x;
    return 1;
}

/* The room that columns of points, sizes and markers have grows with that of points. */
static int grow_columns(plan *d, int sizes, int markers)
{
    size_t k;
    for (k = 0; k < d->column_count; k++) {
        if (!grow((void **)&d->columns[k].values, d->point_count, sizeof(double))) {
            return 0;
        }
    }
    return (!sizes || grow((void **)&d->sizes, d->point_count, sizeof *d->sizes))
        && (!markers || grow((void **)&d->point_markers, d->point_count, sizeof *d->point_markers));
}

/* The line of points: their number, dimension, attributes, whether there are markers. */
static int read_head(text *t, plan *d, double *n, int *markers)
{
    double x[3] = { 2, 0, 0 };
    if (!count(t, "points", n)) {
        return 0;
    }
    if (rest(t, x, 3) < 0 || x[0] < 2 || x[0] > 2) {
        return refuse(t, "the dimension 2 is needed after the number of points%s",
                      x[0] >= 3 && x[0] <= 3 ? "; pbw fill takes facets in space" : "");
    }
    if (!(x[1] >= 0 && x[1] <= MOST_ATTRIBUTES) || x[1] > floor(x[1])) {
        return refuse(t, "the number of attributes is needed, up to %d", MOST_ATTRIBUTES);
    }
    *markers = x[2] > 0;
    if (*n > 0 && d->columns == NULL) {
        d->column_count = (size_t)x[1];
        d->columns = (pbwio_column *)calloc(d->column_count + 1, sizeof *d->columns);
    }
    return *n <= 0 || d->columns != NULL || refuse(t, "out of memory");
}

/* column: which number after the point's own has its size, from 1; 0 = none.  dropped: whether numbers are not
   announced. */
static int read_points(text *t, plan *d, double *base, int column, int *dropped)
{
    double n, x[MOST_ATTRIBUTES + 5], i;
    int got, markers = 0, marker = 0;
    size_t k;
    if (!read_head(t, d, &n, &markers)) {
        return 0;
    }
    for (i = 0; i < n; i++) {
        if (!number(t, 1, x) || (got = rest(t, x + 1, MOST_ATTRIBUTES + 4)) < 2) {
            return refuse(t, "a point with its number, x and y is needed");
        }
        if (got < 2 + (int)d->column_count) {
            return refuse(t, "%d attribute%s, %zu announced", got - 2, plural((size_t)got - 2), d->column_count);
        }
        if (column > got || column > MOST_ATTRIBUTES + 4) {
            return refuse(t, "there is no column %d", column);
        }
        *base = i > 0 ? *base : x[0];
        if (x[0] < *base + i || x[0] > *base + i) {
            return refuse(t, "point %.0f is needed here", *base + i);
        }
        *dropped |= got > 2 + (int)d->column_count + markers;
        if (!marker_of(t, markers && got > 2 + (int)d->column_count ? x[3 + d->column_count] : 0, &marker)) {
            return 0;
        }
        if (!grow_columns(d, column > 0, markers)) {
            return refuse(t, "out of memory");
        }
        for (k = 0; k < d->column_count; k++) {
            d->columns[k].values[d->point_count] = x[3 + k];
        }
        if (column > 0) {
            d->sizes[d->point_count] = x[column];
        }
        if (markers) {
            d->point_markers[d->point_count] = marker;
        }
        if (!append_point(d, x[1], x[2])) {
            return refuse(t, "out of memory");
        }
    }
    return 1;
}

static int read_segments(text *t, plan *d, double base)
{
    double n, x[4], i;
    source from;
    memset(&from, 0, sizeof from);
    from.feature = PBW_NONE;
    if (!count(t, "segments", &n)) {
        return 0;
    }
    rest(t, x, 0);
    for (i = 0; i < n; i++) {
        int got;
        if (!number(t, 1, x) || (got = rest(t, x + 1, 3)) < 2) {
            return refuse(t, "a segment with its number and two points is needed");
        }
        if (!(x[1] - base >= 0 && x[1] - base < (double)d->point_count && x[2] - base >= 0
              && x[2] - base < (double)d->point_count)) {
            return refuse(t, "a segment from point %.0f to point %.0f, but points are %.0f to %.0f", x[1], x[2], base,
                          base + (double)d->point_count - 1);
        }
        from.line = t->line;
        if (!marker_of(t, got > 2 ? x[3] : 0, &from.marker)) {
            return 0;
        }
        if (!append_segment(d, (size_t)(x[1] - base), (size_t)(x[2] - base), from)) {
            return refuse(t, "out of memory");
        }
    }
    return 1;
}

/* The label of an attribute: the tag of a whole number, else its text. */
static int label_of(double attribute, label *of)
{
    char name[32];
    of->is = 1;
    of->tag = fabs(attribute) < 9e15 ? (long long)attribute : 0;
    of->name = NULL;
    if ((double)of->tag < attribute || (double)of->tag > attribute) {
        snprintf(name, sizeof name, "%.15g", attribute);
        of->name = copy_of(name);
        return of->name != NULL;
    }
    return 1;
}

/* Regions: x, y, an attribute, and above 0 the largest area of a triangle. */
static int read_regions(text *t, plan *d, label **labels)
{
    double n, x[5], i;
    if (!number(t, 1, &n)) {                         /* they may be left out */
        return *t->at == 0 || refuse(t, "the number of regions is needed");
    }
    rest(t, x, 0);
    for (i = 0; i < n; i++) {
        int got;
        pbw_plane_region *region;
        if (!number(t, 1, x) || (got = rest(t, x + 1, 4)) < 3) {
            return refuse(t, "a region with its number, x, y and attribute is needed");
        }
        if (!grow((void **)&d->regions, d->region_count, sizeof *region)
            || !grow((void **)labels, d->region_count, sizeof **labels)
            || !label_of(x[3], *labels + d->region_count)) {
            return refuse(t, "out of memory");
        }
        region = d->regions + d->region_count++;
        region->x = x[1];
        region->y = x[2];
        region->area = got > 3 && x[4] > 0 ? x[4] : 0;
    }
    return 1;
}

static int read_holes(text *t, plan *d)
{
    double n, x[5], i;
    label *labels = NULL;
    size_t k;
    int ok;
    if (!count(t, "holes", &n)) {
        return 0;
    }
    rest(t, x, 0);
    for (i = 0; i < n; i++) {
        if (!number(t, 1, x) || rest(t, x + 1, 2) < 2) {
            return refuse(t, "a hole with its number, x and y is needed");
        }
        if (!grow((void **)&d->holes, d->hole_count, 2 * sizeof *d->holes)) {
            return refuse(t, "out of memory");
        }
        memcpy(d->holes + 2 * d->hole_count++, x + 1, 2 * sizeof *x);
    }
    ok = read_regions(t, d, &labels);
    if (ok && d->region_count > 0 && !make_groups(d, labels, d->region_count, &d->region_groups)) {
        ok = refuse(t, "out of memory");
    }
    for (k = 0; labels != NULL && k < d->region_count; k++) {
        free(labels[k].name);
    }
    free(labels);
    return ok;
}

/* Without points the .poly file takes those of the .node file of its name. */
static int read_poly(text *t, plan *d, int column, int *dropped)
{
    char path[1100];
    double base = 0;
    text nodes;
    int ok = read_points(t, d, &base, column, dropped);
    if (ok && d->point_count == 0) {
        snprintf(path, sizeof path, "%.*s.node", (int)(strrchr(t->name, 'y') - t->name) - 4, t->name);
        ok = open_text(&nodes, path, t->build) && read_points(&nodes, d, &base, column, dropped);
        if (!ok) {
            memcpy(t->error, nodes.error, sizeof t->error);
        }
        free(nodes.data);
    }
    d->base = (int)base;
    return ok && read_segments(t, d, base) && read_holes(t, d);
}

/* ---- all of them ---- */

/* Whether a path ends so, or so and with .gz. */
static int ends_with(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    n -= n > 3 && strcmp(path + n - 3, ".gz") == 0 ? 3 : 0;
    return n > m && strncmp(path + n - m, ending, m) == 0;
}

/* Whether a .json file is GeoJSON: its first "type" is one of that. */
static int is_geojson(const char *path, const pbw_options *build)
{
    static const char *const types[] = { "FeatureCollection", "Feature", "GeometryCollection", "Polygon",
                                         "MultiPolygon", "LineString", "MultiLineString" };
    size_t size, i;
    char *data = ends_with(path, ".json") ? pbwio_load(path, build, &size, NULL) : NULL;
    const char *at = data != NULL ? strstr(data, "\"type\"") : NULL;
    int found = 0;
    if (at != NULL) {
        at += 6 + strspn(at + 6, " \t\r\n:\"");
    }
    for (i = 0; at != NULL && i < sizeof types / sizeof types[0]; i++) {
        const size_t length = strlen(types[i]);
        found |= strncmp(at, types[i], length) == 0 && at[length] == '"';
    }
    free(data);
    return found;
}

/* Points or triangles, as for `pbw mesh`, of one plane, with heights. */
static int read_points_of(job *j, plan *d, const char *column)
{
    int failed;
    j->read.weight = column != NULL && column[0] == '#' ? column + 1 : column;
    failed = load(j, 1);
    if (!failed && j->cloud.dim != 2) {
        return fail(j, "%s: points in the plane are needed; --dim 2 takes z for heights", j->input);
    }
    return failed ? failed : take_cloud(j, d);
}

int read_domain(job *j, plan *d, const char *column)
{
    const char *digits = column != NULL && column[0] == '#' ? column + 1 : NULL;
    const double start = now();
    text t;
    int ok, poly, dropped = 0;
    memset(d, 0, sizeof *d);
    if (j->input == NULL || (!ends_with(j->input, ".poly") && !ends_with(j->input, ".geojson")
                             && !is_geojson(j->input, &j->build))) {
        if (is_given(j, "--region-by")) {
            return fail(j, "%s: --region-by needs GeoJSON, with features", j->input);
        }
        return read_points_of(j, d, column);
    }
    poly = ends_with(j->input, ".poly");
    if (column != NULL && (!poly || digits == NULL || atoi(digits) < 1)) {
        return fail(j, "--size %s: columns of .poly files have numbers, #3 is the first attribute; .geojson has none",
                    column);
    }
    begin(j, "read", j->input);
    j->stage = "read";
    ok = open_text(&t, j->input, &j->build)
        && (poly ? read_poly(&t, d, digits != NULL ? atoi(digits) : 0, &dropped) : read_geojson(j, &t, d));
    j->stage = NULL;
    free(t.data);
    if (!ok) {
        const char *limit = strstr(t.error, "out of memory") != NULL ? text_of(j, "--memory-limit") : NULL;
        domain_free(d);
        return interrupted ? stopped(j) : fail(j, "%s%s%s", t.error, limit != NULL ? " within --memory-limit " : "",
                                               limit != NULL ? limit : "");
    }
    if (dropped) {
        warn(j, "%s: numbers behind points that their first line does not announce are left out", j->input);
    }
    d->has_windings = d->polygon_count > 0;
    d->has_seeds = poly;
    if (poly) {
        report_line(j, "%zu point%s, %zu segment%s, %zu hole%s, %zu region%s", COUNT(d->point_count),
                    COUNT(d->segment_count), COUNT(d->hole_count), COUNT(d->region_count));
    } else {
        report_line(j, "%zu point%s, %zu segment%s, %zu polygon%s, %zu feature%s", COUNT(d->point_count),
                    COUNT(d->segment_count), COUNT(d->polygon_count), COUNT(d->feature_count));
    }
    report_step(j, "read", now() - start, "%s", "");
    return 0;
}
