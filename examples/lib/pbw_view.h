/* pbw_view.h - v0.2.0 - pages to look at triangulations in a browser - MIT-0

   QUICK START
   In one source file, define PBW_VIEW_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw_io.h, with its implementation in some source file.

       pbwview_write("mesh.html", &mesh, NULL, &error);

   FUNCTIONS
     pbwview_write  writes a mesh as a page

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>base64       numbers and texts in a page
     >>data         points, corners, arrays, flags
     >>emit         the file
     >>page         the page: HTML and styles
     >>figures      its scripts: data, measures, colours, camera, chart
     >>scene        its scripts: what is shown, and how WebGL draws it
     >>panel        its scripts: the panel beside the picture

   HOW
     The page is one file that needs a browser with WebGL 2, no network and no server.
     1. The mesh can be turned, cut open (simplices whole or cut through), exploded, thinned out by value, and
        coloured by quality and by your own arrays, with a histogram; by mouse, touch and keys.
     2. A click shows the ids of the mesh.
     3. A mesh without simplices (dim, point_count and points set, the rest 0) is shown as points, or with the
        triangles of a model as a surface.

   PROMISES  (tests/test_view.c and tests/page.sh guard them)
     all there   ids, corners, values and names are in the page; coordinates in single precision
     small       about 7 bytes a tetrahedron, 4 a triangle, 20 a point (15 in 2D), for each array 1 to 7 bytes a
     number whole       there is the whole page or none
     bounded     memory: 4 bytes a point
     quiet       no globals, nothing printed, no exit
*/
#ifndef PBW_VIEW_H
#define PBW_VIEW_H
/* ------------------------------------------------------------------------------------------------------
   >>interface    types and functions
   ------------------------------------------------------------------------------------------------------ */
#ifndef PBW_IO_H
#include "pbw_io.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define PBWVIEW_MOST ((size_t)1 << 23)   /* simplices, and points: more is too much for browsers */

typedef struct pbwview_array {         /* numbers to colour by */
    const char *name;
    const uint32_t *whole;             /* one of the two */
    const double *real;                /* NaN and infinities: no value */
    int of_points;                     /* 1: one a point, 0: one a simplex */
    int of_facets;                     /* 1: tetrahedra: one a facet, at 4 t + i that across from corner i of t */
    int classes;                       /* whole numbers: 1: that name something, and get colours that tell them apart;
                                          0: that measure something.  PBW_NONE: no value */
    const char *const *names;          /* UTF-8, of the classes 0, 1, ...; NULL = their numbers */
    size_t name_count;
} pbwview_array;

typedef struct pbwview_options {       /* NULL or all zero = best defaults */
    const char *title, *note;          /* UTF-8, any characters; NULL = "pbw", none */
    const unsigned char *keep;         /* one a simplex, 0 = not part of the body; NULL = all are */
    const unsigned char *inside;       /* one a simplex, 0 = outside the model: hidden at first; NULL = not known */
    int body;                          /* 1: all simplices are part of it; 0: slivers at the hull are hidden at first
    */
    const pbw_index *triangles;        /* faces of the model, three points each: shown first, not cut; NULL = none */
    size_t triangle_count;
    const double *heights;             /* 2D: one a point, shown as a surface in space; NULL = flat */
    int surface;                       /* 1: with heights: triangles of a surface in space, measured there; it need
    not
                                          lie over the plane */
    const pbwview_array *arrays;
    size_t array_count;
    const char *colour;                /* name of the array shown first; NULL = the quality; of points alone the
                                          first array, or z (2D: y) */
    double eye[3], up[3];              /* directions from the middle to the viewer and upwards (0: guessed) */
    double cut[4];                     /* normal of the cut, and its place: -1 cuts all, 1 nothing; 0: through the
                                          middle, towards the viewer; nothing where there are triangles */
    int cut_through;                   /* 1: tetrahedra at the cut are cut through, 0: they stay whole or go */
    int colour_outside;                /* 3D: 1: colours on the outside too, 0: where it is cut open */
    const pbw_options *build;          /* memory_limit, resize, as in pbw.h; NULL = defaults */
    int cells;                         /* 1: cells: the simplices around one first corner, to which only the facets
                                          across from that belong; shown whole, and by arrays of the caller */
} pbwview_options;

/* Writes the page whole or not at all.  Needs no neighbors. */
PBWDEF pbwio_status pbwview_write(const char *path, const pbw_mesh *mesh, const pbwview_options *options,
                                  pbwio_error *error);

#ifdef __cplusplus
}
#endif
#endif /* PBW_VIEW_H */

#if defined(PBW_VIEW_IMPLEMENTATION) && !defined(PBWVIEW__IMPLEMENTED)
#define PBWVIEW__IMPLEMENTED

#include <float.h>
#include <math.h>
#include <string.h>

/* Returns the lines of one of three parts of the page: up to the title, up to the data, after the data.  NULL ends
   the lines.  They are at the end of this file. */
static const char *const *pbwview__part(int part);

/* ------------------------------------------------------------------------------------------------------
   >>base64       Numbers and texts in a page.
   In: bytes, numbers, texts.  Out: lines of base64; texts with their signs escaped.
   Holds: all numbers are little-endian; whole ones have seven bits a byte.
   ------------------------------------------------------------------------------------------------------ */

typedef struct pbwview__page {
    const pbw_mesh *mesh;
    const pbwview_options *options;
    pbw_index *number;                 /* per point: its number on the page, which is the order in which corners meet
                                          it; PBW_NONE if it is not there.  NULL: a page of points, all there */
    pbw_memory memory;
    size_t simplices, points;          /* that are there */
    double middle[3], half;            /* of the box of the points */
    FILE *file;
    unsigned char in[3];               /* bytes on their way to base64 */
    int in_count, out_count;
    char out[4096];
} pbwview__page;

static void pbwview__flush(pbwview__page *page)
{
    fwrite(page->out, 1, (size_t)page->out_count, page->file);
    putc('\n', page->file);
    page->out_count = 0;
}

static void pbwview__group(pbwview__page *page)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned bits = (unsigned)page->in[0] << 16 | (unsigned)page->in[1] << 8 | page->in[2];
    int i;
    for (i = 0; i < 4; i++) {
        page->out[page->out_count++] = i <= page->in_count ? digits[bits >> (18 - 6 * i) & 63] : '=';
    }
    page->in_count = 0;
    if (page->out_count == (int)sizeof page->out) {
        pbwview__flush(page);
    }
}

static void pbwview__byte(pbwview__page *page, unsigned byte)
{
    page->in[page->in_count++] = (unsigned char)byte;
    if (page->in_count == 3) {
        pbwview__group(page);
    }
}

static void pbwview__end(pbwview__page *page)
{
    if (page->in_count > 0) {
        page->in[2] = 0;
        page->in[1] = page->in_count == 1 ? 0 : page->in[1];
        pbwview__group(page);
    }
    pbwview__flush(page);
    fputs("</script>\n", page->file);
}

/* Seven bits a byte, the lowest first; all bytes but the last have the top bit. */
static void pbwview__whole(pbwview__page *page, uint64_t x)
{
    for (; x > 127; x >>= 7) {
        pbwview__byte(page, (unsigned)(x & 127) | 128);
    }
    pbwview__byte(page, (unsigned)x);
}

static void pbwview__float(pbwview__page *page, double x)
{
    float f = x > FLT_MAX ? FLT_MAX : x < -FLT_MAX ? -FLT_MAX : (float)x;
    uint32_t bits;
    int i;
    memcpy(&bits, &f, sizeof bits);
    for (i = 0; i < 32; i += 8) {
        pbwview__byte(page, bits >> i & 255);
    }
}

static void pbwview__doubles(pbwview__page *page, const double *x, int count)
{
    uint64_t bits;
    int i, k;
    for (i = 0; i < count; i++) {
        memcpy(&bits, x + i, sizeof bits);
        for (k = 0; k < 64; k += 8) {
            pbwview__byte(page, (unsigned)(bits >> k & 255));
        }
    }
}

/* Text for between tags and for between quotes. */
static void pbwview__text(FILE *file, const char *text)
{
    for (; *text != 0; text++) {
        if (strchr("&<>\"'", *text) != NULL) {
            fprintf(file, "&#%d;", *text);
        } else {
            putc(*text, file);
        }
    }
}

static void pbwview__lines(FILE *file, const char *const *line)
{
    for (; *line != NULL; line++) {
        fputs(*line, file);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>data         The data of a page: points, corners, arrays, flags.
   In: a mesh, the options.  Out: a script of type text/plain for each kind of data, as data.js reads it.
   Holds: points are numbered in the order in which corners of simplices, then of triangles meet them.
   ------------------------------------------------------------------------------------------------------ */

static int pbwview__kept(const pbwview__page *page, size_t simplex)
{
    return page->options->keep == NULL || page->options->keep[simplex];
}

static double pbwview__coordinate(const pbwview__page *page, size_t point, int k)
{
    return k < page->mesh->dim ? page->mesh->points[point * (size_t)page->mesh->dim + (size_t)k]
         : page->options->heights != NULL ? page->options->heights[point] : 0;
}

/* The points that are there, in the order of their numbers: calls emit for each. */
static void pbwview__each_point(pbwview__page *page, void (*emit)(pbwview__page *, size_t, void *), void *user)
{
    size_t n = (size_t)page->mesh->dim + 1, i, next = 0;
    if (page->number == NULL) {
        for (i = 0; i < page->points; i++) {
            emit(page, i, user);
        }
        return;
    }
    for (i = 0; i < n * page->mesh->simplex_count; i++) {
        pbw_index point = page->mesh->simplices[i];
        if (pbwview__kept(page, i / n) && page->number[point] == next) {
            emit(page, point, user);
            next++;
        }
    }
    for (i = 0; i < 3 * page->options->triangle_count; i++) {
        if (page->number[page->options->triangles[i]] == next) {
            emit(page, page->options->triangles[i], user);
            next++;
        }
    }
}

/* Grows the box: user is its low, then its high corner. */
static void pbwview__measure(pbwview__page *page, size_t point, void *user)
{
    double *box = (double *)user;
    int k;
    for (k = 0; k < 3; k++) {
        double x = pbwview__coordinate(page, point, k);
        box[k] = x < box[k] ? x : box[k];
        box[3 + k] = x > box[3 + k] ? x : box[3 + k];
    }
}

static void pbwview__point(pbwview__page *page, size_t point, void *user)
{
    int k, dim = page->options->heights != NULL ? 3 : page->mesh->dim;
    (void)user;
    for (k = 0; k < dim; k++) {
        pbwview__float(page, (pbwview__coordinate(page, point, k) - page->middle[k]) / page->half);
    }
}

typedef struct pbwview__column { const pbwview_array *array; uint64_t last; } pbwview__column;

/* Differences of whole numbers: 0 -1 1 -2 2 ... are written 0 1 2 3 4 ... */
static void pbwview__step(pbwview__page *page, uint64_t x, uint64_t *last)
{
    pbwview__whole(page, x >= *last ? 2 * (x - *last) : 2 * (*last - x) - 1);
    *last = x;
}

/* A number of an array. */
static void pbwview__value(pbwview__page *page, size_t i, void *user)
{
    pbwview__column *column = (pbwview__column *)user;
    if (column->array->real != NULL) {
        double x = column->array->real[i];
        pbwview__float(page, x >= -DBL_MAX && x <= DBL_MAX ? x : HUGE_VAL - HUGE_VAL);
    } else {
        pbwview__step(page, column->array->whole[i], &column->last);
    }
}

static void pbwview__array(pbwview__page *page, const pbwview_array *array)
{
    const size_t values = array->of_facets ? 4 : 1;                  /* of a simplex */
    pbwview__column column;
    size_t i;
    if (!array->of_points && page->number == NULL) {
        return;
    }
    column.array = array;
    column.last = 0;
    fputs("<script type='text/plain' data-name='", page->file);
    pbwview__text(page->file, array->name);
    fputs("' data-names='", page->file);
    for (i = 0; i < array->name_count; i++) {
        fputs(i > 0 ? "&#10;" : "", page->file);
        pbwview__text(page->file, array->names[i]);
    }
    fprintf(page->file, "' data-of='%s' data-kind='%s'>\n",
            array->of_points ? "points" : array->of_facets ? "facets" : "simplices",
            array->real != NULL ? "real" : array->classes ? "classes" : "whole");
    if (array->of_points) {
        pbwview__each_point(page, pbwview__value, &column);
    }
    for (i = 0; !array->of_points && i < page->mesh->simplex_count * values; i++) {
        if (pbwview__kept(page, i / values)) {
            pbwview__value(page, i, &column);
        }
    }
    pbwview__end(page);
}

/* A corner is written as how many points before the newest it is, 0 if it is a new one. */
static void pbwview__corners(pbwview__page *page)
{
    size_t n = (size_t)page->mesh->dim + 1, i, next = 0;
    for (i = 0; i < n * page->mesh->simplex_count; i++) {
        if (pbwview__kept(page, i / n)) {
            size_t number = page->number[page->mesh->simplices[i]];
            pbwview__whole(page, next - number);
            next += number == next;
        }
    }
}

static void pbwview__id(pbwview__page *page, size_t point, void *user)
{
    pbwview__step(page, point, (uint64_t *)user);
}

/* Lengths of runs of flags, the first of zeros; where keep is given, only of simplices that are kept. */
static void pbwview__runs(pbwview__page *page, const char *id, const unsigned char *flags, const unsigned char *keep)
{
    size_t i, run = 0;
    int now = 0;
    fprintf(page->file, "<script type='text/plain' id='%s'>\n", id);
    for (i = 0; i < page->mesh->simplex_count; i++) {
        if (keep == NULL || keep[i]) {
            if ((flags[i] != 0) != now) {
                pbwview__whole(page, run);
                run = 0;
                now = !now;
            }
            run++;
        }
    }
    pbwview__whole(page, run);
    pbwview__end(page);
}

/* The ids that points and simplices have in the mesh, which simplices are inside, and the faces of the model. */
static void pbwview__model(pbwview__page *page)
{
    const pbwview_options *o = page->options;
    uint64_t last = 0;
    size_t i;
    fputs("<script type='text/plain' id='ids'>\n", page->file);
    pbwview__each_point(page, pbwview__id, &last);
    pbwview__end(page);
    if (page->simplices > 0 && o->keep != NULL) {
        pbwview__runs(page, "kept", o->keep, NULL);
    }
    if (page->simplices > 0 && o->inside != NULL) {
        pbwview__runs(page, "inside", o->inside, o->keep);
    }
    if (o->triangle_count > 0) {
        fputs("<script type='text/plain' id='triangles'>\n", page->file);
        for (i = 0, last = 0; i < 3 * o->triangle_count; i++) {
            pbw_index point = o->triangles[i];
            pbwview__step(page, page->number == NULL ? point : page->number[point], &last);
        }
        pbwview__end(page);
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>emit         The file: head, data, and the scripts.
   In: a mesh, the options.  Out: the page, or a status and a message.
   Holds: nothing is written before all is known to fit.
   ------------------------------------------------------------------------------------------------------ */

static void pbwview__emit(void *user, FILE *file)
{
    pbwview__page *page = (pbwview__page *)user;
    const pbwview_options *o = page->options;
    double lens[14];
    size_t i;
    int k;
    memcpy(lens, page->middle, 3 * sizeof *lens);
    lens[3] = page->half;
    memcpy(lens + 4, o->eye, 3 * sizeof *lens);
    memcpy(lens + 7, o->up, 3 * sizeof *lens);
    memcpy(lens + 10, o->cut, 4 * sizeof *lens);
    for (k = 0; k < 3 && !(o->cut[k] < 0 || o->cut[k] > 0); k++) {}
    lens[13] = k == 3 && (page->number == NULL || page->mesh->dim == 2 || o->triangle_count > 0) ? 1
             : 0.5 + 0.5 * o->cut[3];
    page->file = file;
    page->in_count = page->out_count = 0;
    pbwview__lines(file, pbwview__part(0));
    fputs("<title>", file);
    pbwview__text(file, o->title != NULL && *o->title != 0 ? o->title : "pbw");
    fputs("</title>\n", file);
    pbwview__lines(file, pbwview__part(1));
    fprintf(file, "<div id='mesh' hidden data-dim='%d' data-points='%lu' data-simplices='%lu' data-heights='%d' "
            "data-surface='%d' data-cap='%d' data-plain='%d' data-triangles='%lu' data-kept='%d' data-cells='%d' "
            "data-note='", page->mesh->dim, (unsigned long)page->points, (unsigned long)page->simplices,
            o->heights != NULL, o->surface != 0, o->cut_through != 0, o->colour_outside == 0,
            (unsigned long)o->triangle_count, o->keep != NULL || o->body, o->cells != 0);
    pbwview__text(file, o->note != NULL ? o->note : "");
    fputs("' data-colour='", file);
    pbwview__text(file, o->colour != NULL ? o->colour : "");
    fputs("'></div>\n<script type='text/plain' id='lens'>\n", file);
    pbwview__doubles(page, lens, 14);
    pbwview__end(page);
    fputs("<script type='text/plain' id='points'>\n", file);
    pbwview__each_point(page, pbwview__point, NULL);
    pbwview__end(page);
    if (page->number != NULL) {
        fputs("<script type='text/plain' id='corners'>\n", file);
        pbwview__corners(page);
        pbwview__end(page);
    }
    pbwview__model(page);
    for (i = 0; i < o->array_count; i++) {
        pbwview__array(page, &o->arrays[i]);
    }
    pbwview__lines(file, pbwview__part(2));
}

/* Numbers the points, counts and measures.  Returns what is wrong, NULL if nothing. */
static const char *pbwview__prepare(pbwview__page *page)
{
    const pbw_mesh *mesh = page->mesh;
    size_t n = (size_t)mesh->dim + 1, i;
    double box[6] = { DBL_MAX, DBL_MAX, DBL_MAX, -DBL_MAX, -DBL_MAX, -DBL_MAX };
    int k;
    for (i = 0; i < mesh->simplex_count; i++) {
        page->simplices += pbwview__kept(page, i) != 0;
    }
    for (i = 0; i < 3 * page->options->triangle_count; i++) {
        if (page->options->triangles[i] >= mesh->point_count) {
            return "a triangle has a corner that is no point";
        }
    }
    page->points = mesh->point_count;
    if (page->simplices > 0) {
        page->number = (pbw_index *)pbw_memory_resize(&page->memory, NULL, 0, mesh->point_count,
                                                      sizeof *page->number);
        if (page->number == NULL) {
            return "out of memory";
        }
        memset(page->number, 0xff, mesh->point_count * sizeof *page->number);
        page->points = 0;
        for (i = 0; i < n * mesh->simplex_count; i++) {
            pbw_index *number = &page->number[mesh->simplices[i]];
            if (pbwview__kept(page, i / n) && *number == PBW_NONE) {
                *number = (pbw_index)page->points++;
            }
        }
        for (i = 0; i < 3 * page->options->triangle_count; i++) {
            pbw_index *number = &page->number[page->options->triangles[i]];
            if (*number == PBW_NONE) {
                *number = (pbw_index)page->points++;
            }
        }
    }
    if (page->points == 0) {
        return "there is nothing to show";
    }
    if (page->simplices > PBWVIEW_MOST || page->points > PBWVIEW_MOST
        || page->options->triangle_count > PBWVIEW_MOST) {
        return "more than 8388608 simplices or points are too much for a browser";
    }
    pbwview__each_point(page, pbwview__measure, box);
    for (k = 0; k < 3; k++) {
        double half = 0.5 * box[3 + k] - 0.5 * box[k];
        page->middle[k] = 0.5 * box[3 + k] + 0.5 * box[k];
        page->half = half > page->half ? half : page->half;
    }
    page->half = page->half > 0 ? page->half : 1;
    return NULL;
}

PBWDEF pbwio_status pbwview_write(const char *path, const pbw_mesh *mesh, const pbwview_options *options,
                                  pbwio_error *error)
{
    pbwview_options defaults;
    pbw_options build;
    const char *what;
    pbwio_status status;
    pbwview__page page;
    if (path == NULL || mesh == NULL || (mesh->dim != 2 && mesh->dim != 3)) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwview_write", "no path or no mesh");
    }
    memset(&defaults, 0, sizeof defaults);
    memset(&page, 0, sizeof page);
    page.mesh = mesh;
    page.options = options == NULL ? &defaults : options;
    pbw_memory_start(&page.memory, page.options->build);
    memset(&build, 0, sizeof build);
    build = page.options->build != NULL ? *page.options->build : build;
    pbw_memory_nest(&page.memory, &build);
    what = pbwview__prepare(&page);
    if (what == NULL) {
        status = pbwio_save(path, pbwview__emit, &page, &build, error);
    } else {
        status = strcmp(what, "out of memory") == 0 ? PBWIO_ERROR_MEMORY : PBWIO_ERROR_ARGUMENT;
        if (error != NULL) {
            snprintf(error->text, sizeof error->text, "%.200s: %s", path, what);
        }
    }
    if (page.number != NULL) {
        (void)pbw_memory_resize(&page.memory, page.number, mesh->point_count, 0, sizeof *page.number);
    }
    return status;
}

/* ------------------------------------------------------------------------------------------------------
   >>page         The page, made of the files in examples/lib/view/ by `make page`: edit those.
   In: nothing.  Out: pbwview__part: lines of HTML, and of the styles.
   Holds: lines are those of the files.
   ------------------------------------------------------------------------------------------------------ */
static const char *const pbwview__part0[] = {
    "<!DOCTYPE html>\n",
    "<html lang='en'>\n",
    "<meta charset='utf-8'>\n",
    "<meta name='generator' content='pbw'>\n",
    NULL
};
static const char *const pbwview__part1[] = {
    "<meta name='viewport' content='width=device-width, initial-scale=1'>\n",
    "<meta http-equiv='Content-Security-Policy' content='default-src &#39;none&#39;; img-src data:;\n",
    " script-src &#39;unsafe-inline&#39;; style-src &#39;unsafe-inline&#39;'>\n",
    "<link rel='icon' href='data:,'>\n",
    "<style>\n",
    ":root { color-scheme: light dark; --paper: #f7f8fa; --panel: #ffffff; --ink: #17202b; --soft: #586474;\n",
    "  --rule: #d5dae1; --mark: #1f6feb; --surface: #9db4c6; }\n",
    "@media (prefers-color-scheme: dark) { :root { --paper: #12161c; --panel: #1b2129; --ink: #e6ebf1;\n",
    "  --soft: #9aa7b6; --rule: #36404c; --mark: #58a6ff; --surface: #8ba3b7; } }\n",
    "* { box-sizing: border-box; }\n",
    "html, body { height: 100%; margin: 0; }\n",
    "body { display: flex; background: var(--paper); color: var(--ink); font: 14px/1.45 system-ui, sans-serif; }\n",
    "#stage { position: relative; flex: 1; min-width: 0; min-height: 0; }\n",
    "canvas { position: absolute; width: 100%; height: 100%; touch-action: none; cursor: grab; outline: 0; }\n",
    "canvas:active { cursor: grabbing; }\n",
    "canvas:focus-visible { outline: 2px solid var(--mark); outline-offset: -3px; }\n",
    "#axes { position: absolute; left: 12px; bottom: 12px; width: 76px; height: 76px; pointer-events: none; }\n",
    "#axes line { stroke-width: 2; stroke-linecap: round; }\n",
    "#axes text { font: 600 11px system-ui, sans-serif; fill: var(--ink); text-anchor: middle;\n",
    "  dominant-baseline: central; }\n",
    "#say { position: absolute; left: 0; right: 0; top: 42%; padding: 0 2em; text-align: center;\n",
    "  color: var(--soft); pointer-events: none; }\n",
    "#panel { width: 300px; overflow-y: auto; padding: 14px 16px; background: var(--panel);\n",
    "  border-left: 1px solid var(--rule); }\n",
    "h1 { margin: 0 0 2px; font-size: 17px; overflow-wrap: anywhere; }\n",
    "p { margin: 0 0 6px; color: var(--soft); overflow-wrap: anywhere; }\n",
    "fieldset { margin: 10px 0 0; padding: 9px 0 0; border: 0; border-top: 1px solid var(--rule); min-width: 0; }\n",
    "legend { float: left; width: 5.6em; padding: 0; font-weight: 600; line-height: 26px; }\n",
    ".row { display: flex; align-items: center; gap: 8px; min-height: 26px; clear: left; }\n",
    ".row.first { clear: none; margin-left: 5.6em; }\n",
    ".row > span:first-child { width: 4.9em; flex: none; color: var(--soft); }\n",
    ".row .typed { width: 5.2em; flex: none; text-align: right; font: inherit; font-variant-numeric: tabular-nums;\n",
    "  color: inherit; background: none; border: 1px solid transparent; border-radius: 4px; padding: 1px 3px; }\n",
    ".row .typed:hover, .row .typed:focus, #go { border-color: var(--rule); background: var(--paper); }\n",
    "#views button { flex: 1; padding: 2px 0; }\n",
    "#mark { position: absolute; width: 100%; height: 100%; pointer-events: none; }\n",
    "#mark line { stroke: var(--mark); stroke-width: 1.5; }\n",
    "#mark circle { fill: var(--mark); stroke: #ffffff; }\n",
    "#bar { margin: 8px 0 0; border: 1.5px solid var(--soft); border-top: 0; text-align: center; font-size: 12px;\n",
    "  line-height: 15px; color: var(--soft); }\n",
    "#tip { position: absolute; left: 0; top: 0; max-width: 240px; padding: 4px 8px; font-size: 12px; pointer-events: none;\n",
    "  background: var(--panel); border: 1px solid var(--rule); border-radius: 5px; }\n",
    "select, button { font: inherit; color: inherit; background: var(--paper); border: 1px solid var(--rule);\n",
    "  border-radius: 5px; padding: 2px 8px; min-width: 0; }\n",
    "select { flex: 1; }\n",
    "button { cursor: pointer; }\n",
    "input[type=range] { flex: 1; min-width: 0; accent-color: var(--mark); }\n",
    ":focus-visible { outline: 2px solid var(--mark); }\n",
    "#chart { display: block; width: 100%; margin: 6px 0 2px; clear: left; }\n",
    "#chart text { font: 11px system-ui, sans-serif; fill: var(--soft); }\n",
    "#classes { display: flex; flex-wrap: wrap; gap: 1px 10px; margin: 4px 0; max-height: 9em; overflow-y: auto; }\n",
    "#classes i { display: inline-block; width: 11px; height: 11px; margin-right: 5px; border-radius: 2px; }\n",
    "#shown { display: block; font-weight: 600; }\n",
    "details { margin-top: 10px; color: var(--soft); }\n",
    "kbd { font: 12px ui-monospace, monospace; border: 1px solid var(--rule); border-radius: 3px;\n",
    "  padding: 0 4px; }\n",
    "[hidden] { display: none !important; }\n",
    "@media (max-width: 700px) { body { flex-direction: column; }\n",
    "  #panel { width: auto; height: 44%; border-left: 0; border-top: 1px solid var(--rule); } }\n",
    "</style>\n",
    "<div id='stage'>\n",
    "<canvas id='canvas' tabindex='0' role='img' aria-describedby='keys'></canvas>\n",
    "<svg id='axes' viewBox='-38 -38 76 76' aria-hidden='true'></svg>\n",
    "<svg id='mark' aria-hidden='true'></svg>\n",
    "<div id='tip' hidden></div>\n",
    "<p id='say' role='status'>Loading &#8230;</p>\n",
    "</div>\n",
    "<main id='panel'>\n",
    "<h1 id='title'></h1>\n",
    "<p id='facts'></p>\n",
    "<output id='shown'></output>\n",
    "<div id='bar'></div>\n",
    "<fieldset><legend>Colour</legend>\n",
    "<div class='row'><select id='colour' aria-label='Colour by'></select></div>\n",
    "<svg id='chart' viewBox='0 0 268 92' role='img'></svg>\n",
    "<div id='classes'></div>\n",
    "<p id='summary'></p>\n",
    "<p id='about'></p>\n",
    "<label class='row'><span>from</span><input id='from' type='range' min='0' max='1' step='any'>\n",
    "<input class='typed' id='from-is' aria-label='from, typed'></label>\n",
    "<label class='row'><span>to</span><input id='to' type='range' min='0' max='1' step='any'>\n",
    "<input class='typed' id='to-is' aria-label='to, typed'></label>\n",
    "<label class='row'><input id='plain' type='checkbox' checked> plain outside</label>\n",
    "</fieldset>\n",
    "<fieldset class='cut'><legend>Cut</legend>\n",
    "<div class='row'><select id='axis' aria-label='Direction of the cut'>\n",
    "<option value='0'>across x<option value='1'>across y<option value='2'>across z<option value='3'>facing me\n",
    "<option value='4' hidden>oblique\n",
    "</select><button id='flip' title='Show the other side of the cut'>flip</button></div>\n",
    "<label class='row'><span>place</span><input id='cut' type='range' min='0' max='1' step='any'>\n",
    "<input class='typed' id='cut-is' aria-label='cut, typed'></label>\n",
    "<div class='row solid'><span id='cut-what'>simplices</span><select id='cap' aria-label='Simplices at the cut'>\n",
    "<option value='0'>whole<option value='1'>cut through</select></div>\n",
    "</fieldset>\n",
    "<fieldset><legend>Draw</legend>\n",
    "<div class='row'><select id='show' aria-label='Show'><option value='1'>the model<option value='0'>simplices\n",
    "</select></div>\n",
    "<div class='row'><select id='draw' aria-label='Draw'><option value='3'>faces and edges<option value='1'>faces\n",
    "<option value='2'>edges<option value='4'>points</select></div>\n",
    "<label class='row'><input id='outside' type='checkbox'> outside the model, too</label>\n",
    "<label class='row'><input id='slivers' type='checkbox'> hide slivers at the hull</label>\n",
    "<label class='row'><input id='sites' type='checkbox'> sites of the cells</label>\n",
    "<label class='row relief'><span>heights</span><input id='relief' type='range' min='1' max='20' step='any'>\n",
    "<input class='typed' id='relief-is' aria-label='relief, typed'></label>\n",
    "<label class='row mesh'><span>explode</span><input id='explode' type='range' min='0' max='1' step='any'>\n",
    "<input class='typed' id='explode-is' aria-label='explode, typed'></label>\n",
    "<label class='row dots'><span>point size</span><input id='size' type='range' min='.2' max='4' step='any'>\n",
    "<input class='typed' id='size-is' aria-label='size, typed'></label>\n",
    "</fieldset>\n",
    "<fieldset class='view'><legend>View</legend>\n",
    "<div class='row space'><select id='projection' aria-label='Projection'><option value='0'>perspective\n",
    "<option value='1'>parallel</select></div>\n",
    "<div class='row space'><select class='space' id='up' aria-label='Up'><option value='0'>x up<option value='1'>y up\n",
    "<option value='2'>z up<option value='3'>up as given</select></div>\n",
    "<div class='row space' id='views'><button title='From x'>x</button><button title='From -x'>-x</button>\n",
    "<button title='From y'>y</button><button title='From -y'>-y</button><button title='From z'>z</button>\n",
    "<button title='From -z'>-z</button></div>\n",
    "<div class='row'><button id='reset'>Reset view</button><button id='save'>Save PNG</button></div>\n",
    "</fieldset>\n",
    "<fieldset><legend>Find</legend>\n",
    "<div class='row'><select id='go-kind' aria-label='Go to'><option value='1'>simplex<option value='3'>point</select>\n",
    "<input class='typed' id='go' type='number' min='0' aria-label='Id' placeholder='id'></div>\n",
    "<p id='picked' role='status'>Click the picture, or type an id.</p>\n",
    "</fieldset>\n",
    "<details id='keys'><summary>Mouse, touch and keys</summary>\n",
    "A click tells ids, coordinates and measures; the address keeps the view, as a link.\n",
    "Drag turns, right or shift drag moves, the wheel zooms; one finger turns, two move and zoom.\n",
    "With the picture in focus: arrows turn (with shift: move), <kbd>+</kbd> <kbd>-</kbd> zoom,\n",
    "<kbd>[</kbd> <kbd>]</kbd> move the cut, <kbd>f</kbd> turns it to face me,\n",
    "<kbd>e</kbd> <kbd>w</kbd> explode more and less,\n",
    "<kbd>d</kbd> what is drawn, <kbd>c</kbd> next colour, <kbd>0</kbd> resets.\n",
    "</details>\n",
    "<noscript>This page needs JavaScript.</noscript>\n",
    "</main>\n",
    NULL
};
static const char *const pbwview__part2[] = {
/* ------------------------------------------------------------------------------------------------------
   >>figures      Scripts: data, measures, colours, camera, chart.
   In: the data.  Out: arrays of numbers, ranges.
   ------------------------------------------------------------------------------------------------------ */
    "<script>\n",
    "(() => {\n",
    "'use strict';\n",
    "// Helpers: elements by id, numbers as text, vectors.  The files of this folder become one function, in the order in\n",
    "// which page.html names them: base, data, measures, colour, camera, chart, scene, marks, draw, panel.\n",
    "\n",
    "const $ = id => document.getElementById(id), given = $('mesh').dataset, css = name =>\n",
    "  getComputedStyle(document.documentElement).getPropertyValue(name).trim();\n",
    "const dim = +given.dim, flat = dim === 2 && given.heights !== '1', n = dim + 1, W = 4096;\n",
    "// grouped: the simplices around one first corner are a cell, and the facets across from it the cell's.\n",
    "const grouped = given.cells === '1';\n",
    "// surface: triangles of a surface in space; else heights are of a mesh over the plane.\n",
    "const surface = given.surface === '1', space = dim === 3 || surface ? 3 : 2;\n",
    "const count = +given.simplices, points = +given.points;\n",
    "const simplex = grouped ? ['cell', 'cells'] : dim === 3 ? ['tetrahedron', 'tetrahedra'] : ['triangle', 'triangles'];\n",
    "const canvas = $('canvas'), say = text => { $('say').textContent = text; };\n",
    "const whole = x => Math.round(x).toLocaleString('en-US');\n",
    "const many = (count, one, more = one + 's') => whole(count) + ' ' + (count === 1 ? one : more);\n",
    "const short = (x, span = 0) => Number.isInteger(x) && Math.abs(x) < 1e6 ? '' + x\n",
    "  : Math.abs(x) < 1e-3 * span ? '0' : '' + +x.toPrecision(3);\n",
    "window.onerror = text => say('This page failed: ' + text);\n",
    "$('title').textContent = document.title;\n",
    "$('facts').textContent = grouped ? given.note + ' in ' + dim + 'D'\n",
    "  : (count ? many(count, ...simplex) + ', ' : '') + many(points, 'point') + ' in ' + space + 'D'\n",
    "    + (given.note ? '; ' + given.note : '');\n",
    "canvas.addEventListener('webglcontextlost', () => say('The graphics driver gave up: reload the page.'));\n",
    "\n",
    "const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];\n",
    "const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];\n",
    "const unit = a => { const l = Math.hypot(...a) || 1; return a.map(x => x / l); };\n",
    "// Data: what the page carries becomes points, corners, neighbors, ids, the faces of the model.\n",
    "// Cells (polygons), frames of an animation and regions would be decoded here, too.\n",
    "\n",
    "function bytes(node) {\n",
    "  const text = atob(node.textContent), out = new Uint8Array(text.length);\n",
    "  for (let i = 0; i < text.length; i++) out[i] = text.charCodeAt(i);\n",
    "  node.remove();\n",
    "  return out;\n",
    "}\n",
    "// Textures have whole rows of W texels.\n",
    "const rows = (size, each) => Math.max(1, Math.ceil(size / W)) * W * each;\n",
    "\n",
    "// A number with each call: seven bits a byte, the lowest first; all bytes but the last have the top bit.\n",
    "function reader(raw) {\n",
    "  let at = 0;\n",
    "  return () => {\n",
    "    let x = 0, unit = 1, b;\n",
    "    do { b = raw[at++]; x += (b & 127) * unit; unit *= 128; } while (b > 127);\n",
    "    return x;\n",
    "  };\n",
    "}\n",
    "\n",
    "// Points are numbered as corners meet them: 0 is a new one, d the d-th last.\n",
    "function read_corners() {\n",
    "  const number = reader(bytes($('corners'))), corner = new Uint32Array(rows(count, 4));\n",
    "  let next = 0;\n",
    "  for (let i = 0; i < count * n; i++) {\n",
    "    const d = number();\n",
    "    corner[dim === 3 ? i : 4 * (i / 3 | 0) + i % 3] = d ? next - d : next++;\n",
    "  }\n",
    "  return corner;\n",
    "}\n",
    "\n",
    "function read_points() {\n",
    "  const raw = new Float32Array(bytes($('points')).buffer), each = flat ? 2 : 3;\n",
    "  const point = new Float32Array(rows(points, 4));\n",
    "  for (let i = 0; i < points; i++) {\n",
    "    for (let k = 0; k < each; k++) point[4 * i + k] = raw[each * i + k];\n",
    "  }\n",
    "  return point;\n",
    "}\n",
    "\n",
    "// Across each facet: the facet of the other tetrahedron, -1 on the hull.  A facet waits at its least point\n",
    "// for its like.\n",
    "function read_neighbors(corner) {\n",
    "  const other = new Int32Array(4 * count).fill(-1), head = new Int32Array(points).fill(-1);\n",
    "  const next = new Int32Array(4 * count);\n",
    "  const low = new Uint32Array(4 * count), high = new Uint32Array(4 * count);\n",
    "  for (let f = 0; f < 4 * count; f++) {\n",
    "    const t = f & ~3;\n",
    "    let a = corner[t + (f + 1 & 3)], b = corner[t + (f + 2 & 3)], c = corner[t + (f + 3 & 3)], x;\n",
    "    if (a > b) { x = a; a = b; b = x; }\n",
    "    if (b > c) { x = b; b = c; c = x; }\n",
    "    if (a > b) { x = a; a = b; b = x; }\n",
    "    let g = head[a], before = -1;\n",
    "    while (g >= 0 && (low[g] !== b || high[g] !== c)) { before = g; g = next[g]; }\n",
    "    if (g >= 0) {\n",
    "      other[f] = g;\n",
    "      other[g] = f;\n",
    "      if (before < 0) head[a] = next[g]; else next[before] = next[g];\n",
    "    } else {\n",
    "      low[f] = b; high[f] = c; next[f] = head[a]; head[a] = f;\n",
    "    }\n",
    "  }\n",
    "  return other;\n",
    "}\n",
    "\n",
    "// The middle and half the size of the box of the points; eye, up, cut of the options.\n",
    "const lens = [...new Float64Array(bytes($('lens')).buffer)];\n",
    "const middle = lens.slice(0, 3), half = lens[3], EYE = lens.slice(4, 7), CUT = lens.slice(10, 14);\n",
    "const point = read_points(), corner = count ? read_corners() : null;\n",
    "const other = count && dim === 3 ? read_neighbors(corner) : null;\n",
    "\n",
    "// The ids that points and simplices have in the mesh of the program, runs of flags, the faces of the model.\n",
    "function read_steps(node, out) {                        // differences: 0 -1 1 -2 2 ... are 0 1 2 3 4 ...\n",
    "  const number = reader(bytes(node));\n",
    "  for (let i = 0, last = 0; i < out.length; i++) {\n",
    "    const x = number();\n",
    "    out[i] = last += x % 2 ? -(x + 1) / 2 : x / 2;\n",
    "  }\n",
    "  return out;\n",
    "}\n",
    "function each_run(id, then) {                           // the first run is of zeros\n",
    "  const raw = bytes($(id)), number = reader(raw);\n",
    "  for (let i = 0, flag = 0; i < raw.length; flag = 1 - flag) {\n",
    "    const size = number();\n",
    "    then(flag, size);\n",
    "    for (let x = size; x > 127; x = Math.floor(x / 128)) i++;\n",
    "    i++;\n",
    "  }\n",
    "}\n",
    "const point_id = read_steps($('ids'), new Uint32Array(points)), simplex_id = new Uint32Array(count);\n",
    "if ($('kept')) {\n",
    "  let id = 0, next = 0;\n",
    "  each_run('kept', (kept, size) => {\n",
    "    if (kept) for (let i = 0; i < size; i++) simplex_id[next++] = id + i;\n",
    "    id += size;\n",
    "  });\n",
    "} else {\n",
    "  for (let i = 0; i < count; i++) simplex_id[i] = i;\n",
    "}\n",
    "if (grouped) for (let i = 0; i < count; i++) simplex_id[i] = point_id[corner[4 * i]];\n",
    "// Of a cell only its first simplex is counted.\n",
    "const counts = i => !grouped || i === 0 || simplex_id[i] !== simplex_id[i - 1];\n",
    "let inside = null;\n",
    "if ($('inside')) {\n",
    "  let next = 0;\n",
    "  inside = new Uint8Array(count);\n",
    "  each_run('inside', (flag, size) => inside.fill(flag, next, next += size));\n",
    "}\n",
    "const kept_only = given.kept === '1';\n",
    "const triangle_count = +given.triangles, triangle = new Uint32Array(rows(triangle_count, 4));\n",
    "if (triangle_count) {\n",
    "  read_steps($('triangles'), new Uint32Array(3 * triangle_count)).forEach((p, i) => {\n",
    "    triangle[4 * (i / 3 | 0) + i % 3] = p;\n",
    "  });\n",
    "}\n",
    "// Measures: what colours can show.  Each array is computed, or decoded, at its first use: values(a) returns it whole,\n",
    "// value_at(a, i) one value, and summarise(a) adds its range, mean and histogram.\n",
    "\n",
    "// Measures of simplices, from coordinates in single precision (of a mesh over the plane: in the plane).  Corners\n",
    "// of the simplex that is measured, three coordinates each; a, b, c, d are places in this array.\n",
    "const xyz = new Float64Array(12);\n",
    "const SOLID = dim === 3;\n",
    "// The two corners of each edge, then the other two, or one twice.\n",
    "const EDGES = Uint8Array.from(SOLID\n",
    "  ? [0, 3, 6, 9, 0, 6, 3, 9, 0, 9, 3, 6, 3, 6, 0, 9, 3, 9, 0, 6, 6, 9, 0, 3] : [0, 3, 6, 6, 0, 6, 3, 3, 3, 6, 0, 0]);\n",
    "const REGULAR = SOLID ? 2 * Math.sqrt(6) : 2 * Math.sqrt(3);      // longest edge / inradius\n",
    "\n",
    "// The dot product of b - a and c - a.\n",
    "function dot_at(a, b, c) {\n",
    "  return (xyz[b] - xyz[a]) * (xyz[c] - xyz[a]) + (xyz[b + 1] - xyz[a + 1]) * (xyz[c + 1] - xyz[a + 1])\n",
    "    + (xyz[b + 2] - xyz[a + 2]) * (xyz[c + 2] - xyz[a + 2]);\n",
    "}\n",
    "// Twice the area of the triangle a b c.\n",
    "function two_areas(a, b, c) {\n",
    "  const x = xyz[b] - xyz[a], y = xyz[b + 1] - xyz[a + 1], z = xyz[b + 2] - xyz[a + 2];\n",
    "  const u = xyz[c] - xyz[a], v = xyz[c + 1] - xyz[a + 1], w = xyz[c + 2] - xyz[a + 2];\n",
    "  return Math.sqrt((y * w - z * v) ** 2 + (z * u - x * w) ** 2 + (x * v - y * u) ** 2);\n",
    "}\n",
    "// Loads the corners of simplex t; returns 6 volumes of a tetrahedron, 2 areas of a triangle.\n",
    "function load_simplex(t) {\n",
    "  for (let a = 0; a < n; a++) {\n",
    "    const p = 4 * corner[4 * t + a];\n",
    "    for (let k = 0; k < space; k++) xyz[3 * a + k] = point[p + k];\n",
    "  }\n",
    "  if (!SOLID) return two_areas(0, 3, 6);\n",
    "  const x = xyz[3] - xyz[0], y = xyz[4] - xyz[1], z = xyz[5] - xyz[2];\n",
    "  const u = xyz[6] - xyz[0], v = xyz[7] - xyz[1], w = xyz[8] - xyz[2];\n",
    "  return Math.abs((y * w - z * v) * (xyz[9] - xyz[0]) + (z * u - x * w) * (xyz[10] - xyz[1])\n",
    "    + (x * v - y * u) * (xyz[11] - xyz[2]));\n",
    "}\n",
    "function quality(t) {\n",
    "  const size = load_simplex(t);\n",
    "  let sum = 0;\n",
    "  for (let i = 0; i < EDGES.length; i += 4) sum += dot_at(EDGES[i], EDGES[i + 1], EDGES[i + 1]);\n",
    "  return sum > 0 ? Math.min(1, SOLID ? 12 * Math.cbrt(size * size / 4) / sum : 2 * Math.sqrt(3) * size / sum) : 0;\n",
    "}\n",
    "// The least angle has the largest cotangent, and all cotangents of a simplex have its size below.  At the edge e\n",
    "// between faces with edges u and v: tan = |e| 6 volume / (e.e u.v - e.u e.v); in a triangle between u and v:\n",
    "// tan = 2 area / u.v.\n",
    "function angle(t, sign) {                               // sign: 1 for the least, -1 for the largest\n",
    "  const size = load_simplex(t);\n",
    "  let most = -Infinity;\n",
    "  for (let i = 0; i < EDGES.length; i += 4) {\n",
    "    const a = EDGES[i], b = EDGES[i + 1], c = EDGES[i + 2], d = EDGES[i + 3], e = dot_at(a, b, b);\n",
    "    most = Math.max(most, sign * (!SOLID ? dot_at(c, a, b)\n",
    "      : e > 0 ? (e * dot_at(a, c, d) - dot_at(a, b, c) * dot_at(a, b, d)) / Math.sqrt(e) : Infinity));\n",
    "  }\n",
    "  return 180 / Math.PI * Math.atan2(size, sign * most);\n",
    "}\n",
    "function edge(t, sign) {                                // sign: 1 for the longest, -1 for the shortest\n",
    "  load_simplex(t);\n",
    "  let most = -Infinity;\n",
    "  for (let i = 0; i < EDGES.length; i += 4) {\n",
    "    most = Math.max(most, sign * dot_at(EDGES[i], EDGES[i + 1], EDGES[i + 1]));\n",
    "  }\n",
    "  return Math.sqrt(sign * most) * half;\n",
    "}\n",
    "// The inradius is 3 volume / area of the faces, or 2 area / length of the edges.\n",
    "function aspect_ratio(t) {\n",
    "  const size = load_simplex(t);\n",
    "  let long = 0, around = 0;\n",
    "  for (let i = 0; i < EDGES.length; i += 4) {\n",
    "    const length = Math.sqrt(dot_at(EDGES[i], EDGES[i + 1], EDGES[i + 1]));\n",
    "    long = Math.max(long, length);\n",
    "    around += length;\n",
    "  }\n",
    "  if (SOLID) around = two_areas(0, 3, 6) + two_areas(0, 3, 9) + two_areas(0, 6, 9) + two_areas(3, 6, 9);\n",
    "  return Math.min(1e30, long * around / (REGULAR * size));\n",
    "}\n",
    "\n",
    "const arrays = [];\n",
    "// of_points: one value a point, of_facets: one a facet, else one a simplex.  classes, integer, names: see pbw_view.h.\n",
    "// all() returns the values, or one(i) returns the i-th.\n",
    "function add_array(name, given) {\n",
    "  const defaults = { of_points: false, of_facets: false, classes: false, integer: false, names: [], about: '',\n",
    "    log: false, value: null };\n",
    "  arrays.push({ name, ...defaults, ...given });\n",
    "}\n",
    "function values(a) {\n",
    "  if (a.value) return a.value;\n",
    "  if (a.all) return a.value = a.all();\n",
    "  const size = a.of_points ? points : count, out = new Float32Array(size), one = a.one;\n",
    "  for (let i = 0; i < size; i++) out[i] = one(i);\n",
    "  return a.value = out;\n",
    "}\n",
    "const value_at = (a, i) => a.value || !a.one ? values(a)[i] : Math.fround(a.one(i));\n",
    "const is_value = x => Math.abs(x) < 1e38;               // not NaN, not infinite\n",
    "const told = (a, x) => a.names[x] || (is_value(x) ? short(x) : 'none');\n",
    "const counted = (a, i) => a.of_points || a.of_facets || counts(i);\n",
    "// A scale that shows most values: logarithmic where they are positive and span magnitudes, else without the\n",
    "// hundredths at both ends where those take most of the range.\n",
    "function suit_scale(a, rank) {\n",
    "  const m = rank.length, first = rank[m / 100 | 0], last = rank[m - 1 - (m / 100 | 0)];\n",
    "  if (m < 100 || a.classes || a.one || !(a.high > a.low)) return;\n",
    "  if (first > 0 && last > 100 * first) {\n",
    "    a.log = true;\n",
    "    a.about = 'Logarithmic.';\n",
    "  } else if (last > first && last - first < 0.25 * (a.high - a.low)) {\n",
    "    a.low = first;\n",
    "    a.high = last;\n",
    "    a.about = 'Colours from the 1st to the 99th hundredth of the values.';\n",
    "  }\n",
    "}\n",
    "// least, largest, mean, hundredth (a hundredth is below it) of the values; low and high of the scale.\n",
    "function summarise(a) {\n",
    "  if (a.bin) return;\n",
    "  const value = values(a), sorted = new Float32Array(value.length);\n",
    "  let m = 0, sum = 0;\n",
    "  for (let i = 0; i < value.length; i++) {\n",
    "    if (is_value(value[i]) && counted(a, i)) { sorted[m++] = value[i]; sum += value[i]; }\n",
    "  }\n",
    "  const rank = sorted.subarray(0, m).sort();\n",
    "  a.least = a.low = m ? rank[0] : 0;\n",
    "  a.largest = a.high = m ? rank[m - 1] : 0;\n",
    "  a.mean = m ? sum / m : 0;\n",
    "  a.hundredth = m ? rank[m / 100 | 0] : 0;\n",
    "  suit_scale(a, rank);\n",
    "  if (a.log) {                                          // from the least that is above 0, or a millionth of the top\n",
    "    a.high = Math.max(a.high, 1e-30);\n",
    "    a.low = Math.max(a.high / 1e6, rank.find(x => x > 0) || 0);\n",
    "  }\n",
    "  if (a.one === quality) { a.low = 0; a.high = 1; }\n",
    "  a.bin = histogram(a);\n",
    "}\n",
    "// How many values lie in each of equal parts of the scale, or are each of few whole numbers.\n",
    "function histogram(a) {\n",
    "  const span = a.high - a.low, bins = a.integer && span < 64 ? span + 1 : 48, bin = new Float64Array(bins);\n",
    "  for (let i = 0; i < a.value.length; i++) {\n",
    "    const x = a.value[i], place = Math.max(0, at_scale(a, x)) * bins | 0;\n",
    "    const k = bins === span + 1 ? x - a.low : Math.min(bins - 1, place);\n",
    "    if (is_value(x) && counted(a, i)) bin[k]++;\n",
    "  }\n",
    "  return bin;\n",
    "}\n",
    "function add_measures() {\n",
    "  const kind = SOLID ? 'dihedral angle' : 'angle';\n",
    "  add_array('quality', { one: quality, about: 'Mean ratio: ' + (SOLID ? '12 (3 volume)^(2/3)' : '4 sqrt(3) area')\n",
    "    + ' / sum of squared edges; 1 regular, 0 flat.' });\n",
    "  add_array('least ' + kind, { one: t => angle(t, 1), about: 'Degrees'\n",
    "    + (SOLID ? ' between faces; 70.5 in the regular tetrahedron.' : '; 60 in the regular triangle.') });\n",
    "  add_array('largest ' + kind, { one: t => angle(t, -1), about: 'Degrees; near 180: flat.' });\n",
    "  add_array('aspect ratio', { one: aspect_ratio, log: true, about: 'Longest edge / ('\n",
    "    + (SOLID ? '2 sqrt(6)' : '2 sqrt(3)') + ' inradius); 1 regular, larger is worse.  Logarithmic.' });\n",
    "  add_array(SOLID ? 'volume' : 'area', { one: t => load_simplex(t) * (SOLID ? half ** 3 / 6 : half ** 2 / 2),\n",
    "    log: true, about: 'Of each ' + (SOLID ? 'tetrahedron' : 'triangle') + '.  Logarithmic.' });\n",
    "  add_array('shortest edge', { one: t => edge(t, -1), log: true, about: 'Length.  Logarithmic.' });\n",
    "  add_array('longest edge', { one: t => edge(t, 1), log: true, about: 'Length.  Logarithmic.' });\n",
    "}\n",
    "// An array that came with the page.\n",
    "function add_given(node) {\n",
    "  const { name, of, kind } = node.dataset, size = of === 'points' ? points : of === 'facets' ? 4 * count : count;\n",
    "  const names = node.dataset.names ? node.dataset.names.split('\\n') : [], NONE = 4294967295;\n",
    "  const all = () => kind === 'real' ? new Float32Array(bytes(node).buffer)\n",
    "    : read_steps(node, new Float32Array(size)).map(x => x >= NONE ? NaN : x);\n",
    "  add_array(name, { of_points: of === 'points', of_facets: of === 'facets', classes: kind === 'classes',\n",
    "    integer: kind !== 'real', names, all });\n",
    "}\n",
    "if (count && !grouped) add_measures();\n",
    "if (!grouped) {\n",
    "  add_array('order', {\n",
    "    of_points: true, integer: true, about: 'Id in the input.', all: () => new Float32Array(point_id)\n",
    "  });\n",
    "}\n",
    "document.querySelectorAll('script[data-name]').forEach(add_given);\n",
    "const up = flat ? 1 : 2;\n",
    "if (!flat || !arrays.some(a => a.of_points)) {\n",
    "  add_array(dim === 2 && !flat && !surface ? 'height' : 'xyz'[up], { of_points: true,\n",
    "    one: i => (SOLID || flat ? point[4 * i + up] : height[i]) * half + middle[up] });\n",
    "}\n",
    "// Colours: values to the scale, classes to colours that tell them apart.\n",
    "\n",
    "// OKLab (Ottosson 2020, 'A perceptual color space for image processing') to sRGB, with less chroma where the\n",
    "// screen has not as much.\n",
    "function oklch(light, chroma, turn) {\n",
    "  for (;; chroma -= 0.004) {\n",
    "    const a = chroma * Math.cos(turn), b = chroma * Math.sin(turn);\n",
    "    const l = (light + 0.3963377774 * a + 0.2158037573 * b) ** 3;\n",
    "    const m = (light - 0.1055613458 * a - 0.0638541728 * b) ** 3;\n",
    "    const s = (light - 0.0894841775 * a - 1.2914855480 * b) ** 3;\n",
    "    const rgb = [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,\n",
    "      -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,\n",
    "      -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s];\n",
    "    if (chroma <= 0 || rgb.every(x => x >= 0 && x <= 1)) {\n",
    "      return rgb.map(x => Math.round(255 * Math.min(1, Math.max(0,\n",
    "        x < 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055))));\n",
    "    }\n",
    "  }\n",
    "}\n",
    "// A scale of even steps in lightness, so that it reads without seeing hues; classes: the colours of Okabe\n",
    "// and Ito (2008, 'Color universal design') with grey for their black, then the same lighter and darker.\n",
    "const scale = [], classes = [], okabe = [[0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167],\n",
    "  [86, 180, 233], [213, 94, 0], [240, 228, 66], [150, 150, 150]];\n",
    "for (let i = 0; i < 256; i++) {\n",
    "  scale.push(oklch(0.5 + 0.43 * i / 255, 0.165, (285 + 175 * i / 255) * Math.PI / 180));\n",
    "  const step = (i >> 3) % 3, to = step === 1 ? 255 : 0;\n",
    "  classes.push(okabe[i % 8].map(x => Math.round(step ? 0.6 * x + 0.4 * to : x)));\n",
    "}\n",
    "const rgb = c => 'rgb(' + c.join() + ')';\n",
    "const class_of = x => classes[(x % 256 + 256) % 256];\n",
    "const at_scale = (a, x) => !(a.high > a.low) ? 0.5 : a.log ? Math.log(Math.max(x, a.low) / a.low)\n",
    "  / Math.log(a.high / a.low) : (x - a.low) / (a.high - a.low);\n",
    "const off_scale = (a, t) => a.log ? a.low * (a.high / a.low) ** t : a.low + t * (a.high - a.low);\n",
    "// Camera: up, the eye, what is in the middle, how far; fitting, matrices, where a point is on the page.\n",
    "\n",
    "// The box of the points.\n",
    "const bottom = [9, 9, 9], extent = [-9, -9, -9];\n",
    "for (let i = 0; i < points; i++) for (let k = 0; k < 3; k++) {\n",
    "  const x = point[4 * i + k];\n",
    "  if (x < bottom[k]) bottom[k] = x;\n",
    "  if (x > extent[k]) extent[k] = x;\n",
    "}\n",
    "for (let k = 0; k < 3; k++) extent[k] -= bottom[k];\n",
    "\n",
    "// Up: as given, or guessed: y where the body stands on a flat base across y and on less across z, or is much flatter\n",
    "// in y than in x and z, as ground is; else z.\n",
    "function guess_up() {\n",
    "  const base = [0, 0, 0], corners = triangle_count ? triangle : corner, [wide, tall, deep] = extent;\n",
    "  const at = (c, k) => point[4 * c + k], triangles = triangle_count || (dim === 2 ? count : 0);\n",
    "  const facets = triangles || 4 * count, order = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];\n",
    "  for (let f = 0; f < facets; f++) {\n",
    "    if (!triangles && other[f] >= 0) continue;\n",
    "    const c = triangles ? [0, 1, 2].map(k => corners[4 * f + k]) : order[f & 3].map(k => corners[(f & ~3) + k]);\n",
    "    const [u, v] = [1, 2].map(j => [0, 1, 2].map(k => at(c[j], k) - at(c[0], k)));\n",
    "    const area = cross(u, v), all = Math.hypot(...area);\n",
    "    for (let k = 1; k < 3; k++) {\n",
    "      const side = Math.abs(area[k]);\n",
    "      if (side > 0.97 * all && at(c[0], k) < bottom[k] + 0.03 * extent[k]) base[k] += side / 2;\n",
    "    }\n",
    "  }\n",
    "  const steady = [0, 1, 2].map(k => base[k] * extent[k] / Math.max(1e-30, wide * tall * deep));\n",
    "  return steady[1] > 0.05 && steady[1] > 1.5 * steady[2] || tall < 0.4 * Math.min(wide, deep) && tall > 0 ? 1 : 2;\n",
    "}\n",
    "const has_facets = dim === 3 && count + triangle_count > 0;\n",
    "let UP, SIDE, FRONT, home, parallel = false, moved = false;\n",
    "const EYES = [[1, 0.5, 0.5], [0.55, 0.5, 1], [0.55, -1, 0.5]], FACES = [[1, 0, 0], [0, 0, 1], [0, -1, 0]];\n",
    "const given_up = lens.slice(7, 10), has_up = Math.hypot(...given_up) > 0, has_eye = Math.hypot(...EYE) > 0;\n",
    "function set_up_axis(k) {                               // 3: as given\n",
    "  UP = k < 3 ? [0, 1, 2].map(i => +(i === k)) : unit(given_up);\n",
    "  home = flat ? [0, -1, 0] : has_eye ? unit(EYE) : unit(k < 3 ? EYES[k] : EYES[Math.abs(UP[1]) > 0.9 ? 1 : 2]);\n",
    "  const front = Math.abs(dot(UP, home)) < 0.999 ? home : FACES[k < 3 ? k : Math.abs(UP[1]) < 0.9 ? 2 : 1];\n",
    "  SIDE = unit(cross(UP, front));\n",
    "  FRONT = cross(SIDE, UP);\n",
    "}\n",
    "const first_up = flat ? 2 : has_up ? 3 : space === 2 ? 2 : guess_up();\n",
    "function look_along(eye) {\n",
    "  lift = flat ? Math.PI / 2 : Math.asin(Math.max(-1, Math.min(1, dot(eye, UP))));\n",
    "  turn = flat ? 0 : Math.atan2(dot(eye, SIDE), dot(eye, FRONT));\n",
    "}\n",
    "let turn, lift, distance, target, normal, offset, low, high, shown = 0, facets = 0, caps = 0;\n",
    "// Of points alone, their order in the input says least.\n",
    "let array = arrays.find(a => a.name === given.colour) || !count && arrays.slice(1).find(a => a.of_points)\n",
    "  || arrays[0];\n",
    "const number = id => +$(id).value;\n",
    "\n",
    "// To the viewer, right and up.\n",
    "function frame() {\n",
    "  const eye = [0, 1, 2].map(k => Math.cos(lift) * (Math.cos(turn) * FRONT[k] + Math.sin(turn) * SIDE[k])\n",
    "    + Math.sin(lift) * UP[k]);\n",
    "  const right = [0, 1, 2].map(k => -Math.sin(turn) * FRONT[k] + Math.cos(turn) * SIDE[k]);\n",
    "  return [eye, right, cross(eye, right)];\n",
    "}\n",
    "const TAN = Math.tan(Math.PI / 12);\n",
    "const aspect = () => Math.max(0.05, canvas.clientWidth / Math.max(1, canvas.clientHeight));\n",
    "function fit() {\n",
    "  const [eye, right, up] = frame(), step = Math.max(1, points >> 16), box = [1e9, -1e9, 1e9, -1e9], wide = aspect();\n",
    "  for (let pass = 0; pass < 2; pass++) {                             // first the middle, then how far\n",
    "    distance = pass ? 0 : distance;\n",
    "    for (let i = 0; i < points; i += step) {\n",
    "      const p = [0, 1, 2].map(k => point[4 * i + k] - (pass ? target[k] : 0));\n",
    "      const x = dot(p, right), y = dot(p, up);\n",
    "      if (pass) {\n",
    "        distance = Math.max(distance,\n",
    "          (parallel ? 0 : dot(p, eye)) + 1.06 * Math.max(Math.abs(x) / wide, Math.abs(y)) / TAN);\n",
    "      } else {\n",
    "        box[0] = Math.min(box[0], x); box[1] = Math.max(box[1], x);\n",
    "        box[2] = Math.min(box[2], y); box[3] = Math.max(box[3], y);\n",
    "      }\n",
    "    }\n",
    "    if (!pass) target = [0, 1, 2].map(k => (box[0] + box[1]) / 2 * right[k] + (box[2] + box[3]) / 2 * up[k]);\n",
    "  }\n",
    "  distance = Math.max(distance, 1e-6);\n",
    "  moved = false;\n",
    "}\n",
    "// From coordinates to clip space, by columns; how far before the target it begins, and ends.\n",
    "function camera() {\n",
    "  const [eye, right, up] = frame(), reach = Math.hypot(...target) + 1.8 * relief;\n",
    "  const near = parallel ? distance - reach : Math.max(distance - reach, distance * 0.01), far = distance + reach;\n",
    "  const sx = 1 / (TAN * aspect()), sy = 1 / TAN, e = dot(eye, target), s = parallel ? 1 / distance : 1;\n",
    "  const c = (parallel ? 2 : far + near) / (near - far);\n",
    "  const d = (parallel ? far + near : 2 * far * near) / (near - far), w = parallel ? 0 : 1;\n",
    "  const column = k => [s * sx * right[k], s * sy * up[k], c * eye[k], -w * eye[k]];\n",
    "  const matrix = [...column(0), ...column(1), ...column(2), -s * sx * dot(right, target), -s * sy * dot(up, target),\n",
    "    c * (-e - distance) + d, parallel ? 1 : e + distance];\n",
    "  return { eye, right, up, near, far, matrix };\n",
    "}\n",
    "function project(i) {                                   // where point i is on the canvas\n",
    "  const m = camera().matrix, p = [point[4 * i], point[4 * i + 1], point[4 * i + 2], 1];\n",
    "  const clip = [0, 1, 3].map(r => p.reduce((sum, x, k) => sum + m[4 * k + r] * x, 0));\n",
    "  return [canvas.clientWidth * (clip[0] / clip[2] + 1) / 2, canvas.clientHeight * (1 - clip[1] / clip[2]) / 2];\n",
    "}\n",
    "const across = i => normal[0] * point[4 * i] + normal[1] * point[4 * i + 1] + normal[2] * point[4 * i + 2];\n",
    "// Heights over the plane, times a factor; their range is at least a sixth of the others', if that does it.\n",
    "const height = new Float32Array(points);\n",
    "for (let i = 0; i < points; i++) height[i] = point[4 * i + 2];\n",
    "let relief = 1;\n",
    "function set_relief(factor) {\n",
    "  relief = factor;\n",
    "  for (let i = 0; i < points; i++) point[4 * i + 2] = relief * height[i];\n",
    "  if (gl) upload_points();\n",
    "  set_normal(normal);\n",
    "}\n",
    "function own_relief() {\n",
    "  const most = height.reduce((a, b) => Math.max(a, Math.abs(b)), 0);\n",
    "  return space === 2 && most > 0 ? Math.max(1, Math.min(20, Math.round(0.3 / most))) : 1;\n",
    "}\n",
    "function set_normal(a) {\n",
    "  normal = a;\n",
    "  low = Infinity; high = -Infinity;\n",
    "  for (let i = 0; i < points; i++) {\n",
    "    const d = across(i);\n",
    "    low = Math.min(low, d); high = Math.max(high, d);\n",
    "  }\n",
    "}\n",
    "// The plane that the menu names, with the side to the viewer cut away.\n",
    "function face(eye) {\n",
    "  const k = number('axis');\n",
    "  if (k < 4) set_normal(k === 3 ? eye : [0, 1, 2].map(i => i === k ? eye[k] < 0 ? -1 : 1 : 0));\n",
    "}\n",
    "function reset() {\n",
    "  $('up').value = first_up;\n",
    "  set_up_axis(first_up);\n",
    "  const eye = home, along = [0, 1, 2].filter(k => CUT[k]);\n",
    "  look_along(eye);\n",
    "  $('projection').value = 0; parallel = false;\n",
    "  $('show').value = triangle_count ? 1 : 0;\n",
    "  $('outside').checked = $('sites').checked = false; $('slivers').checked = dim === 3 && count > 0 && !kept_only;\n",
    "  if (along.length) {\n",
    "    set_normal(unit(CUT.slice(0, 3)));\n",
    "    $('axis').value = along.length > 1 ? 4 : along[0];\n",
    "  } else {\n",
    "    const seen = eye.map((x, k) => extent[k] > 0 ? Math.abs(x) : -1);\n",
    "    $('axis').value = seen.indexOf(Math.max(...seen));\n",
    "    face(eye);\n",
    "  }\n",
    "  $('cut').value = flat ? 1 : CUT[3];\n",
    "  $('relief').value = own_relief();\n",
    "  if (dim === 2) set_relief(number('relief'));\n",
    "  $('explode').value = 0; $('size').value = 1; $('cap').value = given.cap;\n",
    "  $('draw').value = count || triangle_count ? 3 : 4;\n",
    "  $('plain').checked = has_facets && given.plain === '1';\n",
    "  set_body();\n",
    "  fit();\n",
    "  set_array(array);\n",
    "}\n",
    "// Chart: the histogram of the array that colours show, and its facts.\n",
    "\n",
    "const svg = (tag, attributes, text) => {\n",
    "  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);\n",
    "  for (const k in attributes) node.setAttribute(k, attributes[k]);\n",
    "  if (text !== undefined) node.textContent = text;\n",
    "  return node;\n",
    "};\n",
    "function draw_chart() {\n",
    "  const a = array, span = a.high - a.low, bin = a.bin, bins = bin.length, chart = $('chart'), wide = 268 / bins;\n",
    "  const most = Math.max(1, ...bin);\n",
    "  chart.replaceChildren();\n",
    "  for (let k = 0; k < bins; k++) {\n",
    "    const c = a.classes && span < 64 ? class_of(a.low + k) : a.classes ? [128, 128, 128]\n",
    "      : scale[Math.round(255 * (bins > 1 ? k / (bins - 1) : 0.5))];\n",
    "    const tall = bin[k] ? Math.max(1, 70 * bin[k] / most) : 0;\n",
    "    chart.append(svg('rect', { x: k * wide, width: wide - (wide > 3 ? 1 : 0), y: 72 - tall, height: tall,\n",
    "      fill: rgb(c) }), svg('rect', { x: k * wide, width: wide + 0.3, y: 73, height: 5, fill: rgb(c) }));\n",
    "  }\n",
    "  if (!a.classes) [0, 0.5, 1].forEach((t, i) => chart.append(svg('text', { x: 268 * t, y: 90,\n",
    "    'text-anchor': ['start', 'middle', 'end'][i] }, short(off_scale(a, t), a.log ? 0 : span))));\n",
    "  const facts = a.classes && a.names.length ? many(bin.filter(x => x).length, 'name')\n",
    "    : a.classes ? 'classes ' + short(a.low) + ' to ' + short(a.high)\n",
    "    : 'least ' + short(a.least, a.log ? 0 : span) + ', 1 % below ' + short(a.hundredth, span) + ', mean '\n",
    "      + short(a.mean, span) + ', largest ' + short(a.largest);\n",
    "  chart.setAttribute('aria-label', 'Histogram of ' + a.name + ': ' + facts);\n",
    "  $('summary').textContent = facts;\n",
    "  $('about').textContent = a.about;\n",
    "  $('classes').replaceChildren();\n",
    "  for (let k = 0; a.classes && k < bins && span < 64; k++) {\n",
    "    const label = document.createElement('span'), mark = document.createElement('i');\n",
    "    mark.style.background = rgb(class_of(a.low + k));\n",
    "    label.append(mark, told(a, a.low + k));\n",
    "    label.title = whole(bin[k]);\n",
    "    if (bin[k]) $('classes').append(label);\n",
    "  }\n",
    "}\n",
    "function set_array(a) {\n",
    "  summarise(a);\n",
    "  array = a;\n",
    "  $('colour').value = arrays.indexOf(a);\n",
    "  $('from').value = 0; $('to').value = 1;\n",
    "  if (gl) upload_values();\n",
    "  draw_chart();\n",
    "  change();\n",
    "}\n",
/* ------------------------------------------------------------------------------------------------------
   >>scene        Scripts: what is shown, and how WebGL draws it.
   In: arrays, the cut.  Out: the picture, marks.
   ------------------------------------------------------------------------------------------------------ */
    "// Scene: which simplices, faces and points are drawn, from cut, limits, body and mode.  In: the controls; out: ids,\n",
    "// facets, cut_ids, caps, shown.\n",
    "\n",
    "function limit(id) {                                    // the value of a slider\n",
    "  const x = off_scale(array, number(id));\n",
    "  return array.integer ? Math.round(x) : x;\n",
    "}\n",
    "const ids = new Uint32Array(rows(Math.max(4 * count, points), 1));\n",
    "const faces = new Uint32Array(triangle_count ? rows(triangle_count, 1) : W);\n",
    "for (let i = 0; i < triangle_count; i++) faces[i] = 4 * i + 3;\n",
    "const cut_ids = new Uint32Array(dim === 3 ? rows(count, 1) : W), state = new Uint8Array(count);\n",
    "const side = new Float32Array(points), site_ids = new Uint32Array(grouped ? rows(points, 1) : W);\n",
    "let sites = 0;\n",
    "const MOST_EXPLODED = 500000;\n",
    "const as_model = () => triangle_count > 0 && $('show').value === '1' && $('draw').value !== '4';\n",
    "const as_points = () => !as_model() && (!count || $('draw').value === '4');\n",
    "\n",
    "// The simplices that may be shown: not those outside the model; else not slivers that the hull joins by slivers.\n",
    "const body = new Uint8Array(count), SLIVER = 0.05;\n",
    "let hidden = 0;\n",
    "function set_body() {\n",
    "  body.fill(1);\n",
    "  if (inside && !$('outside').checked) {\n",
    "    body.set(inside);\n",
    "  } else if (dim === 3 && count && $('slivers').checked && !inside && !grouped) {\n",
    "    const stack = [];\n",
    "    const take = t => { if (body[t] && value_at(arrays[0], t) < SLIVER) { body[t] = 0; stack.push(t); } };\n",
    "    for (let f = 0; f < 4 * count; f++) if (other[f] < 0) take(f >> 2);\n",
    "    while (stack.length) {\n",
    "      const t = stack.pop();\n",
    "      for (let f = 4 * t; f < 4 * t + 4; f++) if (other[f] >= 0) take(other[f] >> 2);\n",
    "    }\n",
    "  }\n",
    "  if (!body.includes(1)) body.fill(1);\n",
    "  hidden = 0;\n",
    "  for (let t = 0; t < count; t++) hidden += !body[t];\n",
    "}\n",
    "function select() {\n",
    "  const sites_only = grouped && $('sites').checked;\n",
    "  const from = number('from') > 0 ? limit('from') : -Infinity;\n",
    "  const to = number('to') < 1 ? limit('to') : Infinity;\n",
    "  const all = from === -Infinity && to === Infinity;\n",
    "  const cutting = !flat && number('cut') < 1, cap = number('cap') && dim === 3, value = array.value;\n",
    "  const fits = x => all || x >= from && x <= to;\n",
    "  offset = low + number('cut') * (high - low);\n",
    "  for (let i = 0; i < points; i++) {\n",
    "    side[i] = cutting ? across(i) - offset : -1;\n",
    "  }\n",
    "  shown = facets = caps = sites = 0;\n",
    "  for (let t = 0; sites_only && t < count; t++) {\n",
    "    if (counts(t) && side[corner[4 * t]] <= 0) site_ids[sites++] = corner[4 * t];\n",
    "  }\n",
    "  if (as_points() && sites_only) {\n",
    "    ids.set(site_ids.subarray(0, sites));\n",
    "    shown = facets = sites;\n",
    "    return;\n",
    "  }\n",
    "  if (as_points()) {\n",
    "    for (let i = 0; i < points; i++) {\n",
    "      if (side[i] <= 0 && (!array.of_points || fits(value[i]))) ids[facets++] = i;\n",
    "    }\n",
    "    shown = facets;\n",
    "    return;\n",
    "  }\n",
    "  for (let t = 0; t < count; t++) {\n",
    "    const c = 4 * t, a = side[corner[c]], b = side[corner[c + 1]], d = side[corner[c + 2]];\n",
    "    const e = dim === 3 ? side[corner[c + 3]] : d;\n",
    "    let s = all ? 1 : 0;\n",
    "    if (!all) {\n",
    "      s = array.of_facets ? 0 : 1;\n",
    "      for (let k = 0; k < n; k++) {\n",
    "        if (array.of_facets) s |= fits(value[c + k]);\n",
    "        else s &= fits(value[array.of_points ? corner[c + k] : t]);\n",
    "      }\n",
    "    }\n",
    "    if (s && cutting) {\n",
    "      if (cap) {\n",
    "        s = a <= 0 || b <= 0 || d <= 0 || e <= 0 ? 1 : 0;\n",
    "        if (s && (a > 0 || b > 0 || d > 0 || e > 0)) cut_ids[caps++] = t;\n",
    "      } else {\n",
    "        s = (grouped ? a : a + b + d + (dim === 3 ? e : 0)) <= 0 ? 1 : 0;\n",
    "      }\n",
    "    }\n",
    "    s &= body[t];\n",
    "    if (!s && cap && caps && cut_ids[caps - 1] === t) caps--;\n",
    "    state[t] = s;\n",
    "    shown += s;\n",
    "  }\n",
    "  if (dim === 2) {\n",
    "    for (let t = 0; t < count; t++) if (state[t]) ids[facets++] = 4 * t + 3;\n",
    "    return;\n",
    "  }\n",
    "  const model = as_model(), apart = !model && (number('explode') > 0 || number('draw') === 2);\n",
    "  if (apart && shown > MOST_EXPLODED) peel();\n",
    "  for (let f = 0; f < 4 * count; f++) {\n",
    "    if (state[f >> 2] === 1) {\n",
    "      const g = other[f];\n",
    "      if (grouped && (f & 3) !== 0) continue;\n",
    "      if (!apart && g >= 0 && state[g >> 2]) continue;\n",
    "      const bared = g >= 0 && body[g >> 2] && (cap || !state[g >> 2]);\n",
    "      if (model && !bared && (!cutting || cap || !crosses(f >> 2))) continue;\n",
    "      ids[facets++] = bared || apart && g >= 0 ? 4 * count + f : f;\n",
    "    }\n",
    "  }\n",
    "}\n",
    "const crosses = t => [0, 1, 2, 3].some(k => side[corner[4 * t + k]] > 0);\n",
    "// Exploded and many: only the outer layers are drawn, state 1; what lies deeper, state 2, they hide.\n",
    "function peel() {\n",
    "  let budget = MOST_EXPLODED, layer = 3, left = shown, grown = 1;\n",
    "  for (let t = 0; t < count; t++) if (state[t]) state[t] = 2;\n",
    "  while (left > 0 && budget > 0 && grown) {\n",
    "    grown = 0;\n",
    "    for (let t = 0; t < count; t++) {\n",
    "      let outer = false;\n",
    "      for (let f = 4 * t; state[t] === 2 && f < 4 * t + 4; f++) {\n",
    "        const g = other[f] >> 2;\n",
    "        outer = outer || g < 0 || !state[g] || state[g] > 2 && state[g] < layer;\n",
    "      }\n",
    "      if (outer) { state[t] = layer; grown++; }\n",
    "    }\n",
    "    budget -= grown; left -= grown; layer++;\n",
    "  }\n",
    "  for (let t = 0; t < count; t++) if (state[t] > 2) state[t] = 1;\n",
    "}\n",
    "// What is beside and over the picture: numbers at the controls, axes, the scale bar, what is picked.\n",
    "const place_sign = () => number('axis') < 3 && normal[number('axis')] < 0 ? -1 : 1;\n",
    "const put = (id, text) => { if (document.activeElement !== $(id)) $(id).value = text; };\n",
    "function show_numbers() {\n",
    "  const dots = as_points(), model = as_model() && (number('cut') >= 1 || dim === 2);\n",
    "  const all = dots ? points : count;\n",
    "  let some = shown, most = all;\n",
    "  if (grouped && !dots) {\n",
    "    some = most = 0;\n",
    "    for (let t = 0, last = -1; t < count; t++) {\n",
    "      most += +counts(t);\n",
    "      if (state[t] && simplex_id[t] !== last) { some++; last = simplex_id[t]; }\n",
    "    }\n",
    "  }\n",
    "  $('shown').textContent = model ? many(triangle_count, 'face') + ' of the model shown'\n",
    "    : whole(some) + ' of ' + many(most, ...(dots ? ['point'] : simplex)) + ' shown';\n",
    "  document.querySelector('.dots').hidden = !dots;\n",
    "  canvas.setAttribute('aria-label', document.title + '. ' + $('shown').textContent + ', coloured by ' + array.name);\n",
    "  const place = place_sign() * (offset * half / (number('axis') === 2 ? relief : 1) + dot(normal, middle));\n",
    "  put('cut-is', number('cut') < 1 ? short(place, half) : 'no cut');\n",
    "  put('relief-is', relief > 1 ? 'times ' + relief : 'as they are');\n",
    "  for (const id of ['from', 'to']) put(id + '-is', short(limit(id), array.log ? 0 : array.high - array.low));\n",
    "  put('explode-is', Math.round(100 * number('explode')) + ' %');\n",
    "  put('size-is', short(number('size')));\n",
    "}\n",
    "// Numbers that are typed beside a slider, as the place of the slider.\n",
    "const from_typed = {\n",
    "  from: x => at_scale(array, x), to: x => at_scale(array, x), explode: x => x / 100, size: x => x, relief: x => x,\n",
    "  cut: x => ((place_sign() * x - dot(normal, middle)) / half * (number('axis') === 2 ? relief : 1) - low)\n",
    "    / (high - low)\n",
    "};\n",
    "let picked = null;                                      // { layer, i } as pick() returns it\n",
    "const coordinates = i => [0, 1, 2].slice(0, flat ? 2 : 3).map(k =>\n",
    "  +((k === 2 && dim === 2 ? height[i] : point[4 * i + k]) * half + middle[k]).toPrecision(7));\n",
    "const corners_of = at => at.layer === 3 ? [at.i] : at.layer === 2 ? [...triangle.subarray(4 * at.i, 4 * at.i + 3)]\n",
    "  : [...corner.subarray(4 * at.i, 4 * at.i + n)];\n",
    "function describe(at, x, y) {                           // x, y: the corner nearest to that place is told, too\n",
    "  const on_facets = a => [0, 1, 2, 3].map(k => values(a)[4 * at.i + k]).filter(is_value).map(x => told(a, x))\n",
    "    .join(', ');\n",
    "  const c = corners_of(at), told_values = arrays.filter(a => a.of_points === (at.layer === 3) && at.layer !== 2)\n",
    "    .map(a => [a.name, a.of_facets ? on_facets(a) : told(a, value_at(a, at.i))]).filter(x => x[1])\n",
    "    .map(x => x.join(' ')), point_text = i => 'point ' + point_id[i] + ' ('\n",
    "      + coordinates(i).join(', ') + ')';\n",
    "  if (at.layer === 3) return point_text(at.i) + '; ' + told_values.join('; ');\n",
    "  const far = i => { const [a, b] = project(i); return Math.hypot(a - x, b - y); };\n",
    "  const nearest = x === undefined ? null : c.reduce((a, b) => far(b) < far(a) ? b : a);\n",
    "  if (grouped && at.layer === 1) return 'cell ' + simplex_id[at.i] + '; ' + told_values.join('; ');\n",
    "  return (at.layer === 2 ? 'face ' + at.i : simplex[0] + ' ' + simplex_id[at.i])\n",
    "    + '; points ' + c.map(i => point_id[i]).join(', ') + (told_values.length ? '; ' + told_values.join('; ') : '')\n",
    "    + (nearest === null ? '' : '; nearest: ' + point_text(nearest));\n",
    "}\n",
    "function set_picked(at, x, y) {\n",
    "  picked = at;\n",
    "  $('picked').textContent = at ? describe(at, x, y) : '';\n",
    "  look();\n",
    "}\n",
    "// To a point or simplex by its id in the mesh: it comes to the middle and is marked.\n",
    "function go_to(kind, id) {\n",
    "  const i = (kind === 3 ? point_id : simplex_id).indexOf(id);\n",
    "  if (i < 0) {\n",
    "    $('picked').textContent = 'None of that id is here.';\n",
    "    return;\n",
    "  }\n",
    "  const c = corners_of({ layer: kind, i }), size = [0, 1, 2].map(k =>\n",
    "    Math.max(...c.map(p => point[4 * p + k])) - Math.min(...c.map(p => point[4 * p + k])));\n",
    "  target = [0, 1, 2].map(k => c.reduce((sum, p) => sum + point[4 * p + k], 0) / c.length);\n",
    "  distance = Math.min(distance, Math.max(0.02, 4 * Math.hypot(...size) / TAN, kind === 3 ? 0.3 / TAN : 0));\n",
    "  moved = true;\n",
    "  set_picked({ layer: kind, i });\n",
    "}\n",
    "function draw_marks({ eye, right, up }) {\n",
    "  $('axes').replaceChildren();\n",
    "  for (const k of [0, 1, 2].slice(0, flat ? 2 : 3).sort((a, b) => eye[a] - eye[b])) {\n",
    "    const x = 25 * right[k], y = -25 * up[k], stroke = ['#d55e00', '#009e73', '#0072b2'][k];\n",
    "    $('axes').append(svg('line', { x1: 0, y1: 0, x2: x, y2: y, stroke }),\n",
    "      svg('text', { x: 1.28 * x, y: 1.28 * y }, 'xyz'[k]));\n",
    "  }\n",
    "  const pixel = 2 * distance * TAN * half / Math.max(1, canvas.clientHeight), most = 140 * pixel;\n",
    "  const ten = 10 ** Math.floor(Math.log10(most)), length = [5, 2, 1].find(x => x * ten <= most) * ten;\n",
    "  $('bar').style.width = length / pixel + 'px';\n",
    "  $('bar').textContent = +length.toPrecision(1);\n",
    "  $('bar').title = parallel || flat ? 'length' : 'length at the middle of the view';\n",
    "  $('mark').replaceChildren();\n",
    "  if (!picked) return;\n",
    "  const at = corners_of(picked).map(project);\n",
    "  at.forEach(([x, y], i) => {\n",
    "    for (const [a, b] of at.slice(i + 1)) $('mark').append(svg('line', { x1: x, y1: y, x2: a, y2: b }));\n",
    "    $('mark').append(svg('circle', { cx: x, cy: y, r: picked.layer === 3 ? 7 : 3.5 }));\n",
    "  });\n",
    "}\n",
    "// Drawing: WebGL 2.  Shaders, textures, the picture, and what lies under a pixel.\n",
    "\n",
    "let gl = canvas.getContext('webgl2', { antialias: false, alpha: false });\n",
    "let trouble = gl ? '' : 'no WebGL 2 here';\n",
    "// All that goes in is the number of a vertex: shaders fetch what they need from textures, 4096 texels a row.\n",
    "const HEAD = `#version 300 es\n",
    "precision highp float; precision highp int; precision highp sampler2D; precision highp usampler2D;\n",
    "uniform mat4 camera; uniform mat3 axes; uniform vec3 surface, ink; uniform vec4 plane;\n",
    "uniform int n, of, classes, plain, draw, clip, lit, grouped, dark;\n",
    "uniform uint bit, layer; uniform float explode, size;\n",
    "uniform sampler2D points, values, colours; uniform usampler2D corners, ids;\n",
    "ivec2 texel(uint i) { return ivec2(i & 4095u, i >> 12); }\n",
    "`;\n",
    "// of: values are of 0 simplices, 1 points, 2 facets.\n",
    "const PLACE = HEAD + `\n",
    "out vec3 edge, weight, at; flat out vec3 value, normal; flat out int bared; flat out uint id;\n",
    "vec3 p[4]; float x[4], s[4];\n",
    "vec3 load(uint t) {\n",
    "  uvec4 c = texelFetch(corners, texel(t), 0);\n",
    "  vec3 sum = vec3(0);\n",
    "  for (int k = 0; k < n; k++) {\n",
    "    p[k] = texelFetch(points, texel(c[k]), 0).xyz;\n",
    "    x[k] = texelFetch(values, texel(of == 1 ? c[k] : of == 2 ? 4u * t + uint(k) : t), 0).x;\n",
    "    s[k] = dot(plane.xyz, p[k]) - plane.w;\n",
    "    sum += p[k];\n",
    "  }\n",
    "  return grouped == 1 ? p[0] : sum / float(n);\n",
    "}\n",
    "void emit(int k, vec3 a, vec3 b, vec3 c, vec3 centre) {\n",
    "  at = k == 0 ? a : k == 1 ? b : c;\n",
    "  edge = weight = vec3(k == 0, k == 1, k == 2);\n",
    "  normal = cross(b - a, c - a);\n",
    "  normal /= max(length(normal), 1e-30);\n",
    "  gl_Position = camera * vec4((at + explode * centre) / (1.0 + explode), 1);\n",
    "}\n",
    "`;\n",
    "const FACET = PLACE + `\n",
    "void main() {\n",
    "  uint f = texelFetch(ids, texel(uint(gl_VertexID / 3)), 0).x;\n",
    "  bared = f >= bit ? 1 : 0;\n",
    "  f = f >= bit ? f - bit : f;\n",
    "  uint i = f & 3u;\n",
    "  ivec3 o = i == 0u ? ivec3(1, 2, 3) : i == 1u ? ivec3(0, 3, 2) : i == 2u ? ivec3(0, 1, 3) : ivec3(0, 2, 1);\n",
    "  id = f >> 2;\n",
    "  vec3 centre = load(id);\n",
    "  emit(gl_VertexID % 3, p[o.x], p[o.y], p[o.z], centre);\n",
    "  value = of == 2 ? vec3(x[i]) : vec3(x[o.x], x[o.y], x[o.z]);\n",
    "  if (grouped == 1) edge.yz = vec2(1);\n",
    "}`;\n",
    "// The section of a tetrahedron: a triangle, or a quadrangle whose diagonal is no edge.\n",
    "const CAP = PLACE + `\n",
    "vec3 q[4]; float y[4]; bool inner[4];\n",
    "void meet(int i, int a, int b) {\n",
    "  inner[i] = grouped == 1 && min(a, b) == 0;\n",
    "  float t = s[a] / (s[a] - s[b]);\n",
    "  q[i] = mix(p[a], p[b], t);\n",
    "  y[i] = of == 2 ? -1.0 : classes == 1 ? (t < 0.5 ? x[a] : x[b]) : mix(x[a], x[b], t);\n",
    "}\n",
    "void main() {\n",
    "  int j = gl_VertexID % 6, o[4], m = 0, below;\n",
    "  id = texelFetch(ids, texel(uint(gl_VertexID / 6)), 0).x;\n",
    "  vec3 centre = load(id);\n",
    "  for (int i = 0; i < 4; i++) if (s[i] <= 0.0) o[m++] = i;\n",
    "  below = m;\n",
    "  for (int i = 0; i < 4; i++) if (s[i] > 0.0) o[m++] = i;\n",
    "  if (below == 2) {\n",
    "    meet(0, o[0], o[2]); meet(1, o[0], o[3]); meet(2, o[1], o[3]); meet(3, o[1], o[2]);\n",
    "  } else {\n",
    "    for (int i = 0; i < 3; i++) meet(i, below == 1 ? o[0] : o[3], below == 1 ? o[i + 1] : o[i]);\n",
    "  }\n",
    "  ivec3 t = j < 3 ? ivec3(0, 1, 2) : ivec3(0, 2, 3);\n",
    "  emit(j % 3, q[t.x], q[t.y], q[t.z], centre);\n",
    "  value = vec3(y[t.x], y[t.y], y[t.z]);\n",
    "  normal = plane.xyz;\n",
    "  bared = 1;\n",
    "  if (inner[t.y] || inner[t.z]) edge.x = 1.0;           // of a cell only what is on its facets is an edge\n",
    "  if (inner[t.z] || inner[t.x]) edge.y = 1.0;\n",
    "  if (inner[t.x] || inner[t.y]) edge.z = 1.0;\n",
    "  if (below == 2 && j < 3) edge.y = 1.0;\n",
    "  if (below == 2 && j >= 3) edge.z = 1.0;\n",
    "  if (below != 2 && j >= 3) gl_Position = vec4(2, 2, 2, 1);\n",
    "}`;\n",
    "const COLOUR = `\n",
    "const vec3 LIGHT = vec3(-0.436, 0.533, 0.726);\n",
    "vec3 colour(float x) {\n",
    "  if (x < 0.0) return surface;\n",
    "  int i = classes == 1 ? int(x) & 255 : int(min(x, 1.0) * 255.0 + 0.5);\n",
    "  return texelFetch(colours, ivec2(i, classes), 0).rgb;\n",
    "}\n",
    "`;\n",
    "const SURFACE = HEAD + COLOUR + `\n",
    "in vec3 edge, weight, at; flat in vec3 value, normal; flat in int bared;\n",
    "out vec4 result;\n",
    "void main() {\n",
    "  if (clip == 1 && dot(plane.xyz, at) > plane.w) discard;\n",
    "  float x = dot(weight, value);\n",
    "  if (classes == 1) x = weight.x > max(weight.y, weight.z) ? value.x : weight.y > weight.z ? value.y\n",
    "    : value.z;\n",
    "  x = min(value.x, min(value.y, value.z)) < 0.0 ? -1.0 : x;\n",
    "  bool bare = plain == 1 && bared == 0;\n",
    "  vec3 c = bare ? surface : colour(x), m = normal * axes;\n",
    "  float bright = max(dot(m.z < 0.0 ? -m : m, LIGHT), 0.0);\n",
    "  c *= lit == 0 ? 1.0 : bare || n == 3 ? 0.44 + 0.64 * bright : 0.72 + 0.34 * bright;\n",
    "  vec3 w = max(fwidth(edge), vec3(1e-9)), d = edge / w;\n",
    "  float near = min(d.x, min(d.y, d.z)), tall = 1.0 / max(w.x, max(w.y, w.z));\n",
    "  float line = (1.0 - smoothstep(0.4, 1.2, near)) * smoothstep(1.0, 8.0, tall);\n",
    "  if (draw == 2 && near > 1.0) discard;\n",
    "  result = vec4(mix(c, ink, draw == 3 ? line * (bare ? 0.24 : 0.5) : 0.0), 1);\n",
    "}`;\n",
    "// What is under a pixel: the layer (1 simplices, 2 the model, 3 points) and the number in it.\n",
    "const PICK = HEAD + `\n",
    "in vec3 at; flat in uint id; out uvec2 result;\n",
    "void main() {\n",
    "  if (clip == 1 && dot(plane.xyz, at) > plane.w) discard;\n",
    "  result = uvec2(layer, id);\n",
    "}`;\n",
    "const DOT = HEAD + `\n",
    "flat out float value; flat out uint id; out vec3 at;\n",
    "void main() {\n",
    "  uint i = texelFetch(ids, texel(uint(gl_VertexID)), 0).x;\n",
    "  id = i;\n",
    "  at = texelFetch(points, texel(i), 0).xyz;\n",
    "  value = of == 1 ? texelFetch(values, texel(i), 0).x : -1.0;\n",
    "  gl_Position = camera * vec4(at, 1);\n",
    "  gl_PointSize = clamp(size / gl_Position.w, 1.5, 64.0);\n",
    "}`;\n",
    "const BALL = HEAD + COLOUR + `\n",
    "flat in float value; out vec4 result;\n",
    "void main() {\n",
    "  vec2 d = 2.0 * gl_PointCoord - 1.0;\n",
    "  float r = dot(d, d);\n",
    "  if (r > 1.0) discard;\n",
    "  float bright = max(dot(LIGHT, vec3(d.x, -d.y, sqrt(1.0 - r))), 0.0);\n",
    "  result = vec4((dark == 1 ? ink : colour(value)) * (lit == 0 ? 1.0 : 0.5 + 0.55 * bright), 1);\n",
    "}`;\n",
    "const SCREEN = `#version 300 es\n",
    "void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0, 1); }`;\n",
    "// Obscurance: how much of the sky over a pixel the depth buffer around it hides (after McGuire, Osman,\n",
    "// Bukowski and Hennessy 2011, 'The Alchemy screen-space ambient obscurance algorithm').\n",
    "const SHADE = `#version 300 es\n",
    "precision highp float; precision highp sampler2D;\n",
    "uniform sampler2D picture, depth; uniform vec4 lens, range; uniform float reach; out vec4 result;\n",
    "vec3 spot(ivec2 p) {                                    // at a depth z the view is lens.xy + z lens.zw wide and high\n",
    "  float d = texelFetch(depth, p, 0).x, z = (range.x + range.y * d) / (range.z + range.w * d);\n",
    "  return vec3((2.0 * (vec2(p) + 0.5) / vec2(textureSize(depth, 0)) - 1.0) * (lens.xy + z * lens.zw), -z);\n",
    "}\n",
    "void main() {\n",
    "  ivec2 p = ivec2(gl_FragCoord.xy), most = textureSize(depth, 0) - 1;\n",
    "  result = vec4(texelFetch(picture, p, 0).rgb, 1);\n",
    "  if (reach <= 0.0 || texelFetch(depth, p, 0).x >= 1.0) return;\n",
    "  ivec2 h = ivec2(1, 0), v = ivec2(0, 1);\n",
    "  vec3 a = spot(p), l = a - spot(p - h), r = spot(p + h) - a, d = a - spot(p - v), u = spot(p + v) - a;\n",
    "  vec3 normal = normalize(cross(abs(l.z) < abs(r.z) ? l : r, abs(d.z) < abs(u.z) ? d : u));\n",
    "  float pixels = clamp(reach * float(most.y) / (2.0 * (lens.y - a.z * lens.w)), 4.0, 200.0), sum = 0.0;\n",
    "  for (int i = 0; i < 32; i++) {\n",
    "    float t = (float(i) + 0.5) / 32.0, angle = float(i) * 2.399963;\n",
    "    vec3 to = spot(clamp(p + ivec2(round(pixels * t * vec2(cos(angle), sin(angle)))), ivec2(0), most)) - a;\n",
    "    float far = length(to);\n",
    "    sum += max(0.0, dot(normal, to) / max(far, 1e-9) - 0.12) * max(0.0, 1.0 - far / (2.0 * reach));\n",
    "  }\n",
    "  result.rgb *= mix(1.0, 0.42, min(1.0, sum / 11.0));\n",
    "}`;\n",
    "\n",
    "function program(vertex, fragment) {\n",
    "  const out = gl.createProgram();\n",
    "  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {\n",
    "    const shader = gl.createShader(kind);\n",
    "    gl.shaderSource(shader, source);\n",
    "    gl.compileShader(shader);\n",
    "    gl.attachShader(out, shader);\n",
    "  }\n",
    "  gl.linkProgram(out);\n",
    "  if (!gl.getProgramParameter(out, gl.LINK_STATUS)) {\n",
    "    const logs = gl.getAttachedShaders(out).map(s => gl.getShaderInfoLog(s));\n",
    "    throw new Error([gl.getProgramInfoLog(out), ...logs].join(' '));\n",
    "  }\n",
    "  const at = {};\n",
    "  for (let i = 0; i < gl.getProgramParameter(out, gl.ACTIVE_UNIFORMS); i++) {\n",
    "    const name = gl.getActiveUniform(out, i).name;\n",
    "    at[name] = gl.getUniformLocation(out, name);\n",
    "  }\n",
    "  return { out, at };\n",
    "}\n",
    "const UNITS = ['points', 'values', 'colours', 'corners', 'ids', 'picture', 'depth'];\n",
    "function texture(unit, internal, format, type, width, height, data) {\n",
    "  const out = gl.createTexture();\n",
    "  gl.activeTexture(gl.TEXTURE0 + unit);\n",
    "  gl.bindTexture(gl.TEXTURE_2D, out);\n",
    "  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);\n",
    "  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);\n",
    "  gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, type, data);\n",
    "  return out;\n",
    "}\n",
    "const table = (unit, internal, format, type, data, each) =>\n",
    "  texture(unit, internal, format, type, W, data.length / each / W, data);\n",
    "let programs, buffers, value_data, pick_frame;\n",
    "let cut_texture, id_texture, face_texture, corner_texture, triangle_texture, site_texture;\n",
    "function set_up() {\n",
    "  const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);\n",
    "  if (most < W || ids.length / W > most) throw new Error('too large for this graphics card');\n",
    "  programs = { facet: program(FACET, SURFACE), cap: program(CAP, SURFACE), dot: program(DOT, BALL),\n",
    "    shade: program(SCREEN, SHADE), pick_facet: program(FACET, PICK), pick_cap: program(CAP, PICK),\n",
    "    pick_dot: program(DOT, PICK) };\n",
    "  table(0, gl.RGBA32F, gl.RGBA, gl.FLOAT, point, 4);\n",
    "  triangle_texture = table(3, gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT, triangle, 4);\n",
    "  corner_texture = table(3, gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT, corner || new Uint32Array(4 * W), 4);\n",
    "  face_texture = table(4, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, faces, 1);\n",
    "  cut_texture = table(4, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, cut_ids, 1);\n",
    "  site_texture = table(4, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, site_ids, 1);\n",
    "  id_texture = table(4, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, ids, 1);\n",
    "  const pixels = new Uint8Array([...scale, ...classes].flatMap(c => [...c, 255]));\n",
    "  texture(2, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, 256, 2, pixels);\n",
    "  value_data = new Float32Array(rows(Math.max(arrays.some(a => a.of_facets) ? 4 * count : count, points), 1));\n",
    "  table(1, gl.R32F, gl.RED, gl.FLOAT, value_data, 1);\n",
    "}\n",
    "function upload_points() {\n",
    "  gl.activeTexture(gl.TEXTURE0);\n",
    "  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, W, point.length / 4 / W, gl.RGBA, gl.FLOAT, point);\n",
    "}\n",
    "function upload_values() {\n",
    "  const a = array, size = a.value.length;\n",
    "  for (let i = 0; i < size; i++) {\n",
    "    const x = a.value[i];\n",
    "    value_data[i] = !is_value(x) ? -1 : a.classes ? x : Math.max(0, Math.min(1, at_scale(a, x)));\n",
    "  }\n",
    "  gl.activeTexture(gl.TEXTURE1);\n",
    "  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, W, value_data.length / W, gl.RED, gl.FLOAT, value_data);\n",
    "}\n",
    "function upload_ids(texture, data, size) {\n",
    "  gl.activeTexture(gl.TEXTURE4);\n",
    "  gl.bindTexture(gl.TEXTURE_2D, texture);\n",
    "  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, W, Math.ceil(size / W), gl.RED_INTEGER, gl.UNSIGNED_INT, data);\n",
    "}\n",
    "// Where is drawn: four samples a pixel, then one, with depths, for shading.\n",
    "function resize() {\n",
    "  const ratio = Math.min(2, window.devicePixelRatio || 1);\n",
    "  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));\n",
    "  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));\n",
    "  if (buffers && canvas.width === width && canvas.height === height) return;\n",
    "  canvas.width = width; canvas.height = height;\n",
    "  if (buffers) {\n",
    "    buffers.frames.forEach(x => gl.deleteFramebuffer(x));\n",
    "    buffers.stores.forEach(x => gl.deleteRenderbuffer(x));\n",
    "    buffers.textures.forEach(x => gl.deleteTexture(x));\n",
    "  }\n",
    "  const samples = Math.min(4, gl.getParameter(gl.MAX_SAMPLES));\n",
    "  const frames = [gl.createFramebuffer(), gl.createFramebuffer()];\n",
    "  const stores = [gl.RGBA8, gl.DEPTH_COMPONENT24].map(format => {\n",
    "    const out = gl.createRenderbuffer();\n",
    "    gl.bindRenderbuffer(gl.RENDERBUFFER, out);\n",
    "    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);\n",
    "    return out;\n",
    "  });\n",
    "  const textures = [texture(5, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, width, height, null),\n",
    "    texture(6, gl.DEPTH_COMPONENT24, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, width, height, null)];\n",
    "  [gl.COLOR_ATTACHMENT0, gl.DEPTH_ATTACHMENT].forEach((place, i) => {\n",
    "    gl.bindFramebuffer(gl.FRAMEBUFFER, frames[0]);\n",
    "    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, stores[i]);\n",
    "    gl.bindFramebuffer(gl.FRAMEBUFFER, frames[1]);\n",
    "    gl.framebufferTexture2D(gl.FRAMEBUFFER, place, gl.TEXTURE_2D, textures[i], 0);\n",
    "  });\n",
    "  buffers = { frames, stores, textures };\n",
    "}\n",
    "function use(p, values) {\n",
    "  gl.useProgram(p.out);\n",
    "  for (const name in p.at) {\n",
    "    const unit = UNITS.indexOf(name), x = values[name], at = p.at[name];\n",
    "    if (unit >= 0) gl.uniform1i(at, unit);\n",
    "    else if (name === 'bit' || name === 'layer') gl.uniform1ui(at, x);\n",
    "    else if (['explode', 'size', 'reach'].includes(name)) gl.uniform1f(at, x);\n",
    "    else if (typeof x === 'number') gl.uniform1i(at, x);\n",
    "    else if (x.length === 16) gl.uniformMatrix4fv(at, false, x);\n",
    "    else if (x.length === 9) gl.uniformMatrix3fv(at, false, x);\n",
    "    else if (x.length === 4) gl.uniform4fv(at, x);\n",
    "    else gl.uniform3fv(at, x);\n",
    "  }\n",
    "}\n",
    "const hex = text => [1, 3, 5].map(i => parseInt(text.slice(i, i + 2), 16) / 255);\n",
    "const bind = (unit, what) => { gl.activeTexture(gl.TEXTURE0 + unit); gl.bindTexture(gl.TEXTURE_2D, what); };\n",
    "function uniforms(view) {\n",
    "  return { camera: new Float32Array(view.matrix), axes: new Float32Array([...view.right, ...view.up, ...view.eye]),\n",
    "    surface: hex(css('--surface')), ink: [0.04, 0.07, 0.11], plane: [...normal, offset], n, dark: 0,\n",
    "    of: array.of_facets ? 2 : +array.of_points,\n",
    "    classes: +array.classes, plain: +$('plain').checked, draw: number('draw'), clip: 0, lit: +!flat,\n",
    "    grouped: +grouped,\n",
    "    bit: count ? 4 * count : 1, layer: 1, explode: number('explode'),\n",
    "    size: number('size') * canvas.height / TAN * Math.min(0.02, (flat ? 0.7 : 1.3) / Math.sqrt(points))\n",
    "      / (parallel ? distance : 1) };\n",
    "}\n",
    "// Draws what select() chose, by the programs for pictures or for picking.\n",
    "function draw_scene(values, facet, cap, dot) {\n",
    "  bind(4, id_texture);\n",
    "  if (as_points()) {\n",
    "    use(dot, { ...values, layer: 3 });\n",
    "    gl.drawArrays(gl.POINTS, 0, facets);\n",
    "    return;\n",
    "  }\n",
    "  if (as_model()) {                                     // point values colour it; those of simplices do not\n",
    "    const cutting = !flat && number('cut') < 1, one_colour = values.plain || !array.of_points;\n",
    "    bind(3, triangle_texture); bind(4, face_texture);\n",
    "    use(facet, { ...values, n: 3, layer: 2, plain: +one_colour, clip: +cutting, bit: 4 * triangle_count + 4 });\n",
    "    gl.drawArrays(gl.TRIANGLES, 0, 3 * triangle_count);\n",
    "    bind(3, corner_texture); bind(4, id_texture);\n",
    "    if (!cutting || dim === 2) return;\n",
    "  }\n",
    "  use(facet, { ...values, clip: caps ? 1 : 0 });\n",
    "  gl.drawArrays(gl.TRIANGLES, 0, 3 * facets);\n",
    "  if (caps) {\n",
    "    bind(4, cut_texture);\n",
    "    use(cap, values);\n",
    "    gl.drawArrays(gl.TRIANGLES, 0, 6 * caps);\n",
    "  }\n",
    "  if (sites) {                                          // in space cells hide them\n",
    "    bind(4, site_texture);\n",
    "    if (flat) gl.disable(gl.DEPTH_TEST);\n",
    "    use(dot, { ...values, layer: 3, dark: 1 });\n",
    "    gl.drawArrays(gl.POINTS, 0, sites);\n",
    "    gl.enable(gl.DEPTH_TEST);\n",
    "  }\n",
    "}\n",
    "// What is at that place of the canvas: a window of 65 pixels around it, as points reach into it from beside.\n",
    "const WINDOW = 65;\n",
    "function pick(x, y) {\n",
    "  if (!gl || !buffers) return null;\n",
    "  if (!pick_frame) {\n",
    "    const frame = gl.createFramebuffer(), depth = gl.createRenderbuffer();\n",
    "    const what = texture(5, gl.RG32UI, gl.RG_INTEGER, gl.UNSIGNED_INT, WINDOW, WINDOW, null);\n",
    "    bind(5, buffers.textures[0]);\n",
    "    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);\n",
    "    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, what, 0);\n",
    "    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);\n",
    "    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, WINDOW, WINDOW);\n",
    "    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);\n",
    "    pick_frame = frame;\n",
    "  }\n",
    "  const view = camera(), m = view.matrix, a = 2 * x / canvas.clientWidth - 1, b = 1 - 2 * y / canvas.clientHeight;\n",
    "  for (let k = 0; k < 4; k++) {\n",
    "    m[4 * k] = (m[4 * k] - a * m[4 * k + 3]) * canvas.width / WINDOW;\n",
    "    m[4 * k + 1] = (m[4 * k + 1] - b * m[4 * k + 3]) * canvas.height / WINDOW;\n",
    "  }\n",
    "  gl.bindFramebuffer(gl.FRAMEBUFFER, pick_frame);\n",
    "  gl.viewport(0, 0, WINDOW, WINDOW);\n",
    "  gl.enable(gl.DEPTH_TEST);\n",
    "  gl.clearBufferuiv(gl.COLOR, 0, new Uint32Array(4));\n",
    "  gl.clearBufferfv(gl.DEPTH, 0, new Float32Array([1]));\n",
    "  draw_scene(uniforms(view), programs.pick_facet, programs.pick_cap, programs.pick_dot);\n",
    "  const out = new Uint32Array(4);\n",
    "  gl.readPixels(WINDOW >> 1, WINDOW >> 1, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, out);\n",
    "  gl.bindFramebuffer(gl.FRAMEBUFFER, null);\n",
    "  return out[0] ? { layer: out[0], i: out[1] } : null;\n",
    "}\n",
    "let selected = false, asked = false;\n",
    "function paint() {\n",
    "  asked = false;\n",
    "  if (!selected) {\n",
    "    select();\n",
    "    selected = true;\n",
    "    if (gl) {\n",
    "      upload_ids(id_texture, ids, facets);\n",
    "      if (caps) upload_ids(cut_texture, cut_ids, caps);\n",
    "      if (sites) upload_ids(site_texture, site_ids, sites);\n",
    "    }\n",
    "  }\n",
    "  show_numbers();\n",
    "  if (!gl) return;\n",
    "  resize();\n",
    "  const view = camera(), { near, far } = view, wide = [TAN * aspect(), TAN];\n",
    "  gl.bindFramebuffer(gl.FRAMEBUFFER, buffers.frames[0]);\n",
    "  gl.viewport(0, 0, canvas.width, canvas.height);\n",
    "  gl.clearColor(...hex(css('--paper')), 1);\n",
    "  gl.enable(gl.DEPTH_TEST);\n",
    "  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);\n",
    "  draw_scene(uniforms(view), programs.facet, programs.cap, programs.dot);\n",
    "  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, buffers.frames[0]);\n",
    "  gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, buffers.frames[1]);\n",
    "  gl.blitFramebuffer(0, 0, canvas.width, canvas.height, 0, 0, canvas.width, canvas.height,\n",
    "    gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT, gl.NEAREST);\n",
    "  gl.bindFramebuffer(gl.FRAMEBUFFER, null);\n",
    "  gl.disable(gl.DEPTH_TEST);\n",
    "  use(programs.shade, { reach: flat || number('draw') === 2 ? 0 : 0.25,\n",
    "    lens: parallel ? [...wide.map(x => distance * x), 0, 0] : [0, 0, ...wide],\n",
    "    range: parallel ? [near, far - near, 1, 0] : [far * near, 0, far, near - far] });\n",
    "  gl.drawArrays(gl.TRIANGLES, 0, 3);\n",
    "  draw_marks(view);\n",
    "}\n",
    "const look = () => { if (!asked) { asked = true; requestAnimationFrame(paint); } };\n",
    "const change = () => { selected = false; look(); };\n",
/* ------------------------------------------------------------------------------------------------------
   >>panel        Scripts: the panel beside the picture.
   In: mouse, touch, keys.  Out: what is shown, a link.
   ------------------------------------------------------------------------------------------------------ */
    "// Panel: mouse, touch, keys, controls, the link; then the start.\n",
    "\n",
    "const move = (dx, dy) => {                              // in pixels of the page\n",
    "  const [, right, up] = frame(), step = 2 * distance * TAN / Math.max(1, canvas.clientHeight);\n",
    "  moved = true;\n",
    "  target = target.map((x, k) => x - step * (dx * right[k] - dy * up[k]));\n",
    "  look();\n",
    "};\n",
    "const rotate = (dx, dy) => {\n",
    "  if (flat) { move(dx, dy); return; }\n",
    "  moved = true;\n",
    "  turn -= 0.008 * dx;\n",
    "  lift = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, lift + 0.008 * dy));\n",
    "  look();\n",
    "};\n",
    "const zoom = (factor, x = 0, y = 0) => {                // x, y: the place that stays, from the middle\n",
    "  const before = distance;\n",
    "  distance = Math.max(1e-5, Math.min(100, distance * factor));\n",
    "  const rest = 1 - distance / before;\n",
    "  move(-x * rest * before / distance, -y * rest * before / distance);\n",
    "};\n",
    "const fingers = new Map();\n",
    "canvas.addEventListener('pointerdown', e => {\n",
    "  canvas.setPointerCapture(e.pointerId);\n",
    "  $('tip').hidden = true;\n",
    "  fingers.set(e.pointerId, { x: e.clientX, y: e.clientY, from: [e.offsetX, e.offsetY], far: 0,\n",
    "    pans: e.button === 2 || e.shiftKey });\n",
    "});\n",
    "canvas.addEventListener('pointermove', e => {\n",
    "  const f = fingers.get(e.pointerId);\n",
    "  if (!f) { hover(e.offsetX, e.offsetY); return; }\n",
    "  const dx = e.clientX - f.x, dy = e.clientY - f.y, second = [...fingers].find(([id]) => id !== e.pointerId);\n",
    "  if (second) {\n",
    "    const g = second[1], before = Math.hypot(f.x - g.x, f.y - g.y);\n",
    "    const after = Math.hypot(e.clientX - g.x, e.clientY - g.y);\n",
    "    move(dx / 2, dy / 2);\n",
    "    zoom(before / Math.max(after, 1));\n",
    "  } else if (f.pans) {\n",
    "    move(dx, dy);\n",
    "  } else {\n",
    "    rotate(dx, dy);\n",
    "  }\n",
    "  f.x = e.clientX; f.y = e.clientY; f.far += Math.abs(dx) + Math.abs(dy);\n",
    "});\n",
    "// A press that does not move picks; a mouse that passes over little enough is told what is there.\n",
    "const MOST_HOVERED = 400000;\n",
    "let hovered = null;\n",
    "function hover(x, y) {\n",
    "  if (facets + triangle_count > MOST_HOVERED) return;\n",
    "  if (!hovered) requestAnimationFrame(() => {\n",
    "    const at = pick(...hovered);\n",
    "    $('tip').hidden = !at;\n",
    "    if (at) $('tip').textContent = describe(at, ...hovered);\n",
    "    $('tip').style.transform = 'translate(' + Math.min(hovered[0] + 14, canvas.clientWidth - 250) + 'px,'\n",
    "      + Math.min(hovered[1] + 14, canvas.clientHeight - 90) + 'px)';\n",
    "    hovered = null;\n",
    "  });\n",
    "  hovered = [x, y];\n",
    "}\n",
    "canvas.addEventListener('pointerleave', () => { $('tip').hidden = true; });\n",
    "const release = e => {\n",
    "  const f = fingers.get(e.pointerId);\n",
    "  fingers.delete(e.pointerId);\n",
    "  if (f && f.far < 4 && e.type === 'pointerup' && !fingers.size) set_picked(pick(...f.from), ...f.from);\n",
    "};\n",
    "canvas.addEventListener('pointerup', release);\n",
    "canvas.addEventListener('pointercancel', release);\n",
    "canvas.addEventListener('contextmenu', e => e.preventDefault());\n",
    "canvas.addEventListener('wheel', e => {\n",
    "  e.preventDefault();\n",
    "  zoom(Math.exp(Math.max(-1, Math.min(1, e.deltaY * (e.deltaMode ? 0.03 : 0.0015)))),\n",
    "    e.offsetX - canvas.clientWidth / 2, e.offsetY - canvas.clientHeight / 2);\n",
    "}, { passive: false });\n",
    "const nudge = (id, by) => { $(id).value = number(id) + by; change(); };\n",
    "const next = (id, then) => { $(id).selectedIndex = ($(id).selectedIndex + 1) % $(id).length; then(); };\n",
    "canvas.addEventListener('keydown', e => {\n",
    "  const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];\n",
    "  if (e.ctrlKey || e.metaKey || e.altKey) return;\n",
    "  if (arrow) (e.shiftKey ? move : rotate)(20 * arrow[0], 20 * arrow[1]);\n",
    "  else if (e.key === '+' || e.key === '=') zoom(0.9);\n",
    "  else if (e.key === '-') zoom(1 / 0.9);\n",
    "  else if (e.key === '0') reset();\n",
    "  else if (e.key === '[' && !flat) nudge('cut', -0.02);\n",
    "  else if (e.key === ']' && !flat) nudge('cut', 0.02);\n",
    "  else if (e.key === 'f' && !flat) { $('axis').value = 3; face(frame()[0]); change(); }\n",
    "  else if (e.key === 'e') nudge('explode', 0.1);\n",
    "  else if (e.key === 'w') nudge('explode', -0.1);\n",
    "  else if (e.key === 'd' && count) next('draw', change);\n",
    "  else if (e.key === 'c') next('colour', () => set_array(arrays[number('colour')]));\n",
    "  else return;\n",
    "  e.preventDefault();\n",
    "});\n",
    "const on = (id, what, then) => $(id).addEventListener(what, then);\n",
    "for (const id of ['from', 'to', 'cut', 'explode', 'draw', 'cap', 'plain', 'show']) on(id, 'input', change);\n",
    "for (const id in from_typed) {\n",
    "  on(id + '-is', 'change', () => {\n",
    "    const x = parseFloat($(id + '-is').value);\n",
    "    if (x === x) {\n",
    "      $(id).value = from_typed[id](x);\n",
    "      $(id).dispatchEvent(new Event('input'));\n",
    "    }\n",
    "    $(id + '-is').blur();\n",
    "    look();\n",
    "  });\n",
    "}\n",
    "on('sites', 'input', change);\n",
    "for (const id of ['outside', 'slivers']) on(id, 'input', () => { set_body(); change(); });\n",
    "on('projection', 'input', () => { parallel = number('projection') === 1; look(); });\n",
    "function turn_to(eye) {\n",
    "  look_along(eye);\n",
    "  if (!moved) fit();\n",
    "  look();\n",
    "}\n",
    "on('up', 'input', () => {\n",
    "  set_up_axis(number('up'));\n",
    "  turn_to(home);\n",
    "});\n",
    "document.querySelectorAll('#views button').forEach((b, i) => b.addEventListener('click', () =>\n",
    "  turn_to([0, 1, 2].map(k => k === i >> 1 ? 1 - 2 * (i & 1) : 0))));\n",
    "on('go', 'change', () => {\n",
    "  const id = parseInt($('go').value, 10);\n",
    "  if (id >= 0) go_to(number('go-kind'), id);\n",
    "});\n",
    "on('save', 'click', () => {\n",
    "  paint();\n",
    "  canvas.toBlob(blob => {\n",
    "    const link = document.createElement('a');\n",
    "    link.href = URL.createObjectURL(blob);\n",
    "    link.download = document.title.replace(/[^A-Za-z0-9._-]+/g, '-') + '.png';\n",
    "    link.click();\n",
    "    URL.revokeObjectURL(link.href);\n",
    "  });\n",
    "});\n",
    "\n",
    "// ---- the link: the address names the view, and brings it back ----\n",
    "\n",
    "const KEPT = ['up', 'projection', 'show', 'draw', 'axis', 'cap', 'cut', 'relief', 'explode', 'size', 'from', 'to'];\n",
    "const BOXES = ['outside', 'slivers', 'sites', 'plain'];\n",
    "function link_text() {\n",
    "  const numbers = [turn, lift, distance, ...target, ...normal].map(x => +x.toPrecision(6)).join();\n",
    "  return 'view=' + numbers + '&colour=' + encodeURIComponent(array.name) + KEPT.map(id => '&' + id + '='\n",
    "    + +number(id).toPrecision(6)).join('') + BOXES.map(id => '&' + id + '=' + +$(id).checked).join('');\n",
    "}\n",
    "function follow_link() {\n",
    "  const given = new URLSearchParams(location.hash.slice(1)), view = (given.get('view') || '').split(',').map(Number);\n",
    "  if (view.length !== 9 || !view.every(x => Math.abs(x) < 1e9) || !(view[2] > 0)) return;\n",
    "  const a = arrays.find(x => x.name === given.get('colour'));\n",
    "  if (a) set_array(a);\n",
    "  for (const id of KEPT) if (given.has(id)) $(id).value = given.get(id);\n",
    "  for (const id of BOXES) $(id).checked = given.get(id) === '1';\n",
    "  for (const id of ['show', 'draw', 'axis', 'up']) if ($(id).selectedIndex < 0) $(id).selectedIndex = 0;\n",
    "  set_up_axis(number('up') === 3 && !has_up ? 2 : number('up'));\n",
    "  parallel = number('projection') === 1;\n",
    "  if (dim === 2) set_relief(number('relief'));\n",
    "  set_normal(unit(view.slice(6)));\n",
    "  set_body();\n",
    "  [turn, lift, distance] = view;\n",
    "  target = view.slice(3, 6);\n",
    "  moved = true;\n",
    "  change();\n",
    "}\n",
    "let waiting = 0;                                        // browsers count changes of the address: one after each rest\n",
    "function keep_link() {\n",
    "  clearTimeout(waiting);\n",
    "  waiting = setTimeout(() => { if (moved || location.hash) history.replaceState(null, '', '#' + link_text()); }, 300);\n",
    "}\n",
    "for (const what of ['pointerup', 'wheel', 'keyup', 'input', 'change', 'click']) {\n",
    "  document.addEventListener(what, e => { if (e.target.id !== 'reset' && what !== 'pointerup') moved = moved\n",
    "    || e.target.id === 'canvas'; keep_link(); });\n",
    "}\n",
    "window.addEventListener('hashchange', follow_link);\n",
    "\n",
    "on('size', 'input', look);\n",
    "on('relief', 'input', () => { set_relief(number('relief')); change(); });\n",
    "on('colour', 'input', () => {                           // the colours must be seen\n",
    "  const a = arrays[number('colour')];\n",
    "  if (as_model() && !a.of_points && number('cut') >= 1) $('show').value = 0;\n",
    "  if (number('cut') >= 1) $('plain').checked = false;\n",
    "  set_array(a);\n",
    "});\n",
    "on('axis', 'input', () => {\n",
    "  face(frame()[0]);\n",
    "  if (number('cut') >= 1) $('cut').value = 0.5;\n",
    "  change();\n",
    "});\n",
    "on('flip', 'click', () => {\n",
    "  set_normal(normal.map(x => -x));\n",
    "  $('cut').value = 1 - number('cut');\n",
    "  change();\n",
    "});\n",
    "on('reset', 'click', reset);\n",
    "matchMedia('(prefers-color-scheme: dark)').addEventListener('change', look);\n",
    "new ResizeObserver(() => { if (!moved) fit(); look(); }).observe(canvas);\n",
    "\n",
    "arrays.forEach((a, i) => $('colour').append(new Option(a.name, i)));\n",
    "$('go-kind').options[0].textContent = simplex[0];\n",
    "$('show').options[1].textContent = $('cut-what').textContent = simplex[1];\n",
    "$('sites').parentNode.hidden = !grouped;\n",
    "if (!count) document.querySelectorAll('.mesh').forEach(x => { x.hidden = true; });\n",
    "if (!count || dim === 2) document.querySelectorAll('.solid').forEach(x => { x.hidden = true; });\n",
    "$('plain').parentNode.hidden = !has_facets;\n",
    "document.querySelector('.relief').hidden = flat || space === 3;\n",
    "if (flat) document.querySelectorAll('.cut').forEach(x => { x.hidden = true; });\n",
    "if (!count && !triangle_count) $('draw').parentNode.hidden = true;\n",
    "$('show').parentNode.hidden = !triangle_count || !count;\n",
    "$('outside').parentNode.hidden = !inside;\n",
    "$('slivers').parentNode.hidden = dim === 2 || !count || kept_only || inside !== null || grouped;\n",
    "if (flat) document.querySelectorAll('.space').forEach(x => { x.hidden = true; });\n",
    "document.querySelectorAll('fieldset').forEach(x => {    // menus and buttons stand beside the name of their group\n",
    "  const row = x.querySelector('.row:not([hidden])');\n",
    "  if (row && row.matches('div') && !row.querySelector('span')) row.classList.add('first');\n",
    "});\n",
    "$('up').options[3].hidden = !has_up;\n",
    "if (!count) $('go-kind').value = 3;\n",
    "try {\n",
    "  if (gl) set_up();\n",
    "} catch (e) {\n",
    "  trouble = e.message;\n",
    "  gl = null;\n",
    "}\n",
    "reset();\n",
    "paint();\n",
    "follow_link();\n",
    "say(gl ? '' : 'No picture: ' + trouble + '.  The numbers beside this are right.');\n",
    "})();\n",
    "</script>\n",
    "</html>\n",
    NULL
};

static const char *const *pbwview__part(int part)
{
    return part == 0 ? pbwview__part0 : part == 1 ? pbwview__part1 : pbwview__part2;
}
#endif /* PBW_VIEW_IMPLEMENTATION */
