/* domain.c: reads plane domains: .poly and .node as Triangle has them, .geojson; writes .poly.
   In: a file.  Out: points, segments, holes, regions, or a message "name:line: what". */
#include "program.h"
#include <errno.h>
#include <stdarg.h>

/* ---- growing arrays */

static int grow(void **data, size_t count, size_t size)              /* room for one more; at powers of two */
{
    void *more;
    if ((count & (count - 1)) != 0 && count > 0) {
        return 1;
    }
    more = realloc(*data, (count == 0 ? 1 : 2 * count) * size);
    *data = more != NULL ? more : *data;
    return more != NULL;
}

static int add_point(plan *d, double x, double y)
{
    if (!grow((void **)&d->points, d->point_count, 2 * sizeof *d->points)) {
        return 0;
    }
    d->points[2 * d->point_count] = x;
    d->points[2 * d->point_count++ + 1] = y;
    return 1;
}

static int add_segment(plan *d, size_t a, size_t b, int marker)
{
    if (!grow((void **)&d->segments, d->segment_count, 2 * sizeof *d->segments)
        || !grow((void **)&d->markers, d->segment_count, sizeof *d->markers)) {
        return 0;
    }
    d->markers[d->segment_count] = marker;
    d->segments[2 * d->segment_count] = (pbw_index)a;
    d->segments[2 * d->segment_count++ + 1] = (pbw_index)b;
    return 1;
}

void domain_free(plan *d)
{
    free(d->points);
    free(d->segments);
    free(d->markers);
    free(d->holes);
    free(d->sizes);
    free(d->triangles);
    free(d->regions);
    memset(d, 0, sizeof *d);
}

/* ---- text */

typedef struct text {
    const char *name;
    char *data, *at;
    size_t line;
    char error[256];                                 /* the first one */
} text;

PRINTF(2, 3) static int refuse(text *t, const char *format, ...)     /* returns 0 */
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
static int open_text(text *t, const char *path)
{
    FILE *file = strcmp(path, "-") == 0 ? stdin : fopen(path, "rb");
    size_t size = 0, room = 1 << 16, got;
    memset(t, 0, sizeof *t);
    t->name = path;
    t->line = 1;
    if (file == NULL) {
        snprintf(t->error, sizeof t->error, "%.150s: %s", path, strerror(errno));
        return 0;
    }
    t->data = (char *)malloc(room);
    while (t->data != NULL && (got = fread(t->data + size, 1, room - size - 1, file)) > 0) {
        size += got;
        if (size + 1 == room) {
            char *more = (char *)realloc(t->data, room *= 2);
            if (more == NULL) {
                free(t->data);
            }
            t->data = more;
        }
    }
    if (file != stdin) {
        fclose(file);
    }
    if (t->data == NULL) {
        snprintf(t->error, sizeof t->error, "%.150s: out of memory", path);
        return 0;
    }
    t->data[size] = 0;
    t->at = t->data;
    return 1;
}

/* ---- .poly and .node: numbers; # starts a comment */

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

/* The next number of the file, or 0 numbers at its end.  Returns whether there is one. */
static int number(text *t, int lines, double *x)
{
    char *end;
    skip_blanks(t, lines);
    end = t->at;
    *x = *t->at == '\n' ? 0 : strtod(t->at, &end);
    if (end == t->at) {
        return 0;
    }
    t->at = end;
    return 1;
}

static int count(text *t, const char *what, double *x)
{
    if (!number(t, 1, x) || !(*x >= 0 && *x <= 4e9) || *x > floor(*x)) {
        return refuse(t, "the number of %s is needed", what);
    }
    return 1;
}

/* The rest of a line: up to `most` numbers; returns how many there are. */
static int rest(text *t, double *x, int most)
{
    int n = 0;
    double unused;
    while (number(t, 0, n < most ? x + n : &unused)) {
        n++;
    }
    return n;
}

/* column: which number after the point's own has its size, from 1; 0 = none. */
static int read_points(text *t, plan *d, double *base, int column)
{
    double n, x[16], i;
    int got;
    if (!count(t, "points", &n)) {
        return 0;
    }
    rest(t, x, 1);                                   /* dimension, attributes, markers: to be seen in the lines */
    for (i = 0; i < n; i++) {
        if (!number(t, 1, x) || (got = rest(t, x + 1, 15)) < 2) {
            return refuse(t, "a point with its number, x and y is needed");
        }
        if (column > got || column > 15) {
            return refuse(t, "there is no column %d", column);
        }
        if (i == 0) {
            *base = x[0];
        }
        if (x[0] < *base + i || x[0] > *base + i) {
            return refuse(t, "point %.0f is needed here", *base + i);
        }
        if (column > 0 && !grow((void **)&d->sizes, d->point_count, sizeof *d->sizes)) {
            return refuse(t, "out of memory");
        }
        if (column > 0) {
            d->sizes[d->point_count] = x[column];
        }
        if (!add_point(d, x[1], x[2])) {
            return refuse(t, "out of memory");
        }
    }
    return 1;
}

static int read_segments(text *t, plan *d, double base)
{
    double n, x[4], i;
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
        if (!add_segment(d, (size_t)(x[1] - base), (size_t)(x[2] - base), got > 2 ? (int)x[3] : 0)) {
            return refuse(t, "out of memory");
        }
    }
    return 1;
}

static int read_holes(text *t, plan *d)
{
    double n, x[5], i;
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
    if (!number(t, 1, &n)) {                         /* regions may be left out */
        return *t->at == 0 || refuse(t, "the number of regions is needed");
    }
    rest(t, x, 0);
    for (i = 0; i < n; i++) {
        int got;
        pbw_plane_region *region;
        if (!number(t, 1, x) || (got = rest(t, x + 1, 4)) < 3) {
            return refuse(t, "a region with its number, x, y and attribute is needed");
        }
        if (!grow((void **)&d->regions, d->region_count, sizeof *region)) {
            return refuse(t, "out of memory");
        }
        region = d->regions + d->region_count++;
        region->x = x[1];
        region->y = x[2];
        region->area = got > 3 && x[4] > 0 ? x[4] : 0;
    }
    return 1;
}

/* Without points the .poly file takes those of the .node file of its name. */
static int read_poly(text *t, plan *d, int column)
{
    char path[1100];
    double base = 0;
    text nodes;
    int ok = read_points(t, d, &base, column);
    if (ok && d->point_count == 0) {
        snprintf(path, sizeof path, "%.*s.node", (int)(strlen(t->name) - 5), t->name);
        ok = open_text(&nodes, path) && read_points(&nodes, d, &base, column);
        if (!ok) {
            memcpy(t->error, nodes.error, sizeof t->error);
        }
        free(nodes.data);
    }
    d->base = (int)base;
    return ok && read_segments(t, d, base) && read_holes(t, d);
}

/* ---- .geojson: every member "coordinates".  A list of positions is a line, closed if its ends are one place. */

static int read_position(text *t, plan *d)
{
    double x[2] = { 0, 0 }, unused;
    int n = 0;
    while (number(t, 1, n < 2 ? x + n : &unused)) {
        n++;
    }
    skip_blanks(t, 1);
    if (n < 2 || *t->at != ']') {
        return refuse(t, "a position [x, y] is needed");
    }
    t->at++;
    return add_point(d, x[0], x[1]) || refuse(t, "out of memory");
}

/* Ends a list of positions that began with point `first`. */
static int end_line(text *t, plan *d, size_t first)
{
    const size_t n = d->point_count - first;
    size_t i;
    const int closed = n > 2 && memcmp(d->points + 2 * first, d->points + 2 * (d->point_count - 1), 16) == 0;
    d->point_count -= (size_t)closed;
    d->lines += !closed && n > 1;
    for (i = first; i + 1 < first + n; i++) {
        if (!add_segment(d, i, closed && i + 2 == first + n ? first : i + 1, 0)) {
            return refuse(t, "out of memory");
        }
    }
    return 1;
}

static int read_coordinates(text *t, plan *d)
{
    size_t first = d->point_count;
    int depth = 0, in_line = 0;
    do {
        skip_blanks(t, 1);
        if (*t->at == '[') {
            t->at++;
            depth++;
            skip_blanks(t, 1);
            if (*t->at != '[' && *t->at != ']') {
                first = in_line ? first : d->point_count;
                in_line = depth > 1;
                depth--;
                if (!read_position(t, d)) {
                    return 0;
                }
            }
        } else if (*t->at == ']') {
            t->at++;
            depth--;
            if (in_line && !end_line(t, d, first)) {
                return 0;
            }
            in_line = 0;
        } else {
            return refuse(t, "brackets of coordinates do not close");
        }
        if (depth > 8) {
            return refuse(t, "coordinates are nested too deeply");
        }
    } while (depth > 0);
    return 1;
}

static int read_geojson(text *t, plan *d)
{
    char *found;
    while ((found = strstr(t->at, "\"coordinates\"")) != NULL) {
        for (; t->at < found; t->at++) {
            t->line += *t->at == '\n';
        }
        t->at += strlen("\"coordinates\"");
        skip_blanks(t, 1);
        if (*t->at++ != ':' || !read_coordinates(t, d)) {
            return refuse(t, "\"coordinates\" have no value");
        }
    }
    return d->point_count > 0 || refuse(t, "there are no \"coordinates\"");
}

/* ---- all of them */

static int ends_with(const char *path, const char *ending)
{
    const size_t n = strlen(path), m = strlen(ending);
    return n > m && strcmp(path + n - m, ending) == 0;
}

int read_domain(job *j, plan *d, const char *column)
{
    const char *digits = column != NULL && column[0] == '#' ? column + 1 : NULL;
    text t;
    int ok;
    memset(d, 0, sizeof *d);
    if (j->input == NULL || (!ends_with(j->input, ".poly") && !ends_with(j->input, ".geojson"))) {
        int failed;
        j->read.weight = digits != NULL ? digits : column;
        failed = load(j, 1);
        if (!failed && j->cloud.dim != 2) {
            return fail(j, "%s: points in the plane are needed; --dim 2 leaves z out", j->input);
        }
        d->points = j->cloud.points;
        d->point_count = j->cloud.count;
        d->sizes = j->cloud.weights;
        d->triangles = j->cloud.triangles;
        d->triangle_count = j->cloud.triangle_count;
        j->cloud.points = j->cloud.weights = NULL;
        j->cloud.triangles = NULL;
        j->cloud.triangle_count = 0;
        return failed;
    }
    if (column != NULL && (!ends_with(j->input, ".poly") || digits == NULL || atoi(digits) < 1)) {
        return fail(j, "--size %s: columns of .poly files have numbers, #3 is the first attribute; .geojson has none",
                    column);
    }
    ok = open_text(&t, j->input)
        && (ends_with(j->input, ".poly") ? read_poly(&t, d, digits != NULL ? atoi(digits) : 0) : read_geojson(&t, d));
    free(t.data);
    if (!ok) {
        domain_free(d);
        return fail(j, "%s", t.error);
    }
    d->has_windings = ends_with(j->input, ".geojson") && d->segment_count > 0 && d->lines == 0;
    d->has_seeds = ends_with(j->input, ".poly");
    note(j, "%zu point%s, %zu segment%s, %zu hole%s, %zu region%s", COUNT(d->point_count),
         COUNT(d->segment_count), COUNT(d->hole_count), COUNT(d->region_count));
    return 0;
}
