/* features.c: triangles and cells of the plane as GeoJSON (RFC 7946), one feature each, written as they come.
   In: a mesh and what its writers get, or cells with shapes.  Out: a FeatureCollection of polygons, rings closed and
   counter-clockwise, holes clockwise. */
#include "program.h"

/* A number in the fewest digits from 15 to 17 that read back the same. */
static void put_number(FILE *file, double x)
{
    char text[40];
    int digits = 15;
    do {
        snprintf(text, sizeof text, "%.*g", digits, x);
    } while (digits++ < 17 && (strtod(text, NULL) < x || strtod(text, NULL) > x));
    fputs(text, file);
}

static void put_string(FILE *file, const char *s)
{
    fputc('"', file);
    for (; *s != 0; s++) {
        if ((unsigned char)*s < ' ') {
            fprintf(file, "\\u%04x", (unsigned)(unsigned char)*s);
        } else {
            fprintf(file, *s == '"' || *s == '\\' ? "\\%c" : "%c", *s);
        }
    }
    fputc('"', file);
}

static void put_position(FILE *file, const double *x, const double *height)
{
    fputc('[', file);
    put_number(file, x[0]);
    fputc(',', file);
    put_number(file, x[1]);
    if (height != NULL) {
        fputc(',', file);
        put_number(file, *height);
    }
    fputc(']', file);
}

/* What is before the coordinates of a feature. */
static void begin_feature(FILE *file, int first, size_t id, const pbwio_group *region, double area, const char *type)
{
    fprintf(file, "%s\n{\"type\":\"Feature\",\"properties\":{\"id\":%zu,", first ? "" : ",", id);
    if (region != NULL) {
        fprintf(file, "\"region\":%lld,", region->tag);
    }
    if (region != NULL && region->name != NULL) {
        fputs("\"name\":", file);
        put_string(file, region->name);
        fputc(',', file);
    }
    fputs("\"area\":", file);
    put_number(file, area);
    fprintf(file, "},\"geometry\":{\"type\":\"%s\",\"coordinates\":[", type);
}

/* ---- triangles ---- */

typedef struct triangles { const pbw_mesh *mesh; const pbwio_output *output; } triangles;

static void emit_triangles(void *user, FILE *file)
{
    const pbw_mesh *mesh = ((const triangles *)user)->mesh;
    const pbwio_output *o = ((const triangles *)user)->output;
    size_t i, k, count = 0;
    fputs("{\"type\":\"FeatureCollection\",\"features\":[", file);
    for (i = 0; i < mesh->simplex_count; i++) {
        const pbw_index *v = mesh->simplices + 3 * i;
        const double *a = mesh->points + 2 * (size_t)v[0], *b = mesh->points + 2 * (size_t)v[1];
        const double *c = mesh->points + 2 * (size_t)v[2];
        const pbw_index region = o->regions == NULL || o->groups == NULL ? PBW_NONE : o->regions[i];
        if (o->keep != NULL && !o->keep[i]) {
            continue;
        }
        begin_feature(file, count++ == 0, i, region == PBW_NONE ? NULL : o->groups + region,
                      ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2, "Polygon");
        for (k = 0; k < 4; k++) {
            fputs(k == 0 ? "[" : ",", file);
            put_position(file, mesh->points + 2 * (size_t)v[k % 3],
                         o->heights == NULL ? NULL : o->heights + v[k % 3]);
        }
        fputs("]]}}", file);
    }
    fputs("\n]}\n", file);
}

pbwio_status write_triangles(const char *path, const pbw_mesh *mesh, const pbwio_output *output, pbwio_error *error)
{
    triangles t;
    t.mesh = mesh;
    t.output = output;
    return pbwio_save(path, emit_triangles, &t, output->build, error);
}

/* ---- cells ---- */

typedef struct loop { size_t begin, end; double area; } loop;        /* facets; the area is below 0 around holes */

static const double *corner_of(const pbw_cells *cells, size_t facet)
{
    return cells->vertices + 2 * (size_t)cells->loops[cells->loop_first[facet]];
}

/* Whether the first corner of a loop is inside another one. */
static int is_inside(const pbw_cells *cells, const loop *hole, const loop *outer)
{
    const double *p = corner_of(cells, hole->begin);
    size_t f;
    int odd = 0;
    for (f = outer->begin; f < outer->end; f++) {
        const double *a = corner_of(cells, f), *b = corner_of(cells, f + 1 < outer->end ? f + 1 : outer->begin);
        if ((a[1] <= p[1]) != (b[1] <= p[1])) {
            odd ^= (pbw_orient2(a, b, p) > 0) == (b[1] > a[1]);
        }
    }
    return odd;
}

/* The loops of a cell; returns how many.  list NULL: counts only. */
static size_t find_loops(const pbw_cells *cells, size_t cell, loop *list)
{
    size_t f = cells->first[cell], count = 0, i;
    while (f < cells->first[cell + 1]) {
        const size_t end = loop_end(cells, cell, f);
        if (list != NULL) {
            const double *o = corner_of(cells, f);
            list[count].begin = f;
            list[count].end = end;
            list[count].area = 0;
            for (i = f + 1; i + 1 < end; i++) {
                const double *a = corner_of(cells, i), *b = corner_of(cells, i + 1);
                list[count].area += (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
            }
        }
        count++;
        f = end;
    }
    return count;
}

static void put_ring(FILE *file, const pbw_cells *cells, const loop *l)
{
    size_t f;
    fputc('[', file);
    for (f = l->begin; f < l->end; f++) {
        put_position(file, corner_of(cells, f), NULL);
        fputc(',', file);
    }
    put_position(file, corner_of(cells, l->begin), NULL);
    fputc(']', file);
}

/* One polygon for each loop around a part of the cell, with the holes in it. */
static void put_parts(FILE *file, const pbw_cells *cells, const loop *list, size_t count, int several)
{
    size_t i, k, parts = 0;
    for (i = 0; i < count; i++) {
        if (list[i].area < 0) {
            continue;
        }
        fprintf(file, "%s%s", parts++ == 0 ? "" : ",", several ? "[" : "");
        put_ring(file, cells, list + i);
        for (k = 0; k < count; k++) {
            if (list[k].area < 0 && is_inside(cells, list + k, list + i)) {
                fputc(',', file);
                put_ring(file, cells, list + k);
            }
        }
        fputs(several ? "]" : "", file);
    }
}

void emit_cell_features(const pbw_cells *cells, FILE *file, void *room)
{
    loop *list = (loop *)room;
    size_t i, k, n, parts, count = 0;
    fputs("{\"type\":\"FeatureCollection\",\"features\":[", file);
    for (i = 0; i < cells->cell_count; i++) {
        if (is_drawn(cells, i)) {
            n = find_loops(cells, i, list);
            for (k = 0, parts = 0; k < n; k++) {
                parts += !(list[k].area < 0);
            }
            begin_feature(file, count++ == 0, i, NULL, cells->volumes[i], parts > 1 ? "MultiPolygon" : "Polygon");
            put_parts(file, cells, list, n, parts > 1);
            fputs("]}}", file);
        }
    }
    fputs("\n]}\n", file);
}

size_t cell_features_room(const pbw_cells *cells)
{
    size_t i, most = 0;
    for (i = 0; i < cells->cell_count; i++) {
        const size_t n = is_drawn(cells, i) ? find_loops(cells, i, NULL) : 0;
        most = n > most ? n : most;
    }
    return (most + 1) * sizeof(loop);
}
