/* pbw_picture.h - v0.2.0 - pictures of triangulations, as SVG - MIT-0

   QUICK START
   In one source file, define PBW_PICTURE_IMPLEMENTATION before the include; in all others, only include.
   Needs pbw_io.h, with its implementation in some source file.

       pbwpic_write("mesh.svg", &mesh, NULL, &error);

   FUNCTIONS
     pbwpic_write  writes a mesh as an SVG picture

   CONTENTS  (search for the marks)
     >>interface    types and functions
     >>colours      the colour scale; sizes of simplices as colours
     >>raster       a depth buffer, and ambient occlusion from it
     >>faces        which faces are drawn, and where on the screen
     >>emit         the file

   HOW
     2D: all triangles, coloured by area.
     3D: a cut-away view in perspective.
     1. Simplices beyond a plane are removed.
     2. The visible faces of the others are drawn, the farthest first: the hull in one colour, the cut coloured by
        volume.
     3. Both are shaded by one light and by ambient occlusion.
     A picture has no size of its own, and fills the window or the column that it is shown in.

   PROMISES  (tests/test_io.c guards them)
     whole       there is the whole picture or none
     bounded     memory: at most 100 bytes for each face that looks to the viewer, 17 bytes a simplex, 16 MB
     quiet       no globals, nothing printed, no exit
*/
#ifndef PBW_PICTURE_H
#define PBW_PICTURE_H
/* ------------------------------------------------------------------------------------------------------
   >>interface    types and functions
   ------------------------------------------------------------------------------------------------------ */
#ifndef PBW_IO_H
#include "pbw_io.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pbwpic_options {        /* NULL or all zero = best defaults */
    const unsigned char *keep;         /* one a simplex, 0 = not part of the body; NULL = all are */
    double eye[3], up[3];              /* 3D: the directions from the middle to the viewer and upwards (0: z) */
    double cut[4];                     /* 3D: the plane's normal, and its distance from the middle, 1 = the radius of
                                          the body; simplices with their centre beyond it are removed */
    const pbw_options *build;          /* memory_limit, resize, as in pbw.h; NULL = defaults */
} pbwpic_options;

/* Writes the picture whole or not at all.  3D needs mesh->neighbors. */
PBWDEF pbwio_status pbwpic_write(const char *path, const pbw_mesh *mesh, const pbwpic_options *options,
                                 pbwio_error *error);

#ifdef __cplusplus
}
#endif
#endif /* PBW_PICTURE_H */

#if defined(PBW_PICTURE_IMPLEMENTATION) && !defined(PBWPIC__IMPLEMENTED)
#define PBWPIC__IMPLEMENTED

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------------------------------------------
   >>colours      The colour scale, and sizes of simplices as colours.
   In: a mesh.  Out: its frame; a value for each simplex, and the range that the colours show.
   Holds: coordinates are halved before they are subtracted, so that no difference overflows.
   ------------------------------------------------------------------------------------------------------ */

#define PBWPIC__WIDE 1600                      /* pixels of the depth buffer and units of the picture */
#define PBWPIC__HIGH 1200

typedef struct pbwpic__face {                  /* a triangle on the screen */
    float x[3], y[3], z[3];                    /* pixels; z: towards the viewer */
    float shade, value;                        /* value: colour on the scale 0..1; below 0: the hull */
} pbwpic__face;

typedef struct pbwpic__key { float z; unsigned face; } pbwpic__key;

typedef struct pbwpic__view {
    const pbw_mesh *mesh;
    const pbwpic_options *options;
    pbw_memory memory;
    double middle[3], half;                    /* of the points' box: its middle and half its longest side */
    double *value, range[2];                   /* a simplex: logarithm of its size; those that are colours 0 and 1 */
    unsigned char *shown;                      /* a simplex: 0 = not part of the body, 1 = shown, 2 = cut away */
    pbwpic__face *face;
    size_t face_count, face_capacity;
    pbwpic__key *key;                          /* faces that are drawn, from the farthest to the nearest */
    size_t key_count;
    float *depth;                              /* a pixel: z of the nearest face, and which that is */
    unsigned *owner;
    double box[4];                             /* of all faces: least x, y, largest x, y */
} pbwpic__view;

static int pbwpic__compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The colour scale, from small to large, and the colour of the hull below it; as red, green, blue. */
static unsigned pbwpic__colour(double value, double shade)
{
    static const unsigned char scale[6][3] = {
        { 38, 26, 84 }, { 92, 44, 128 }, { 190, 62, 112 }, { 244, 124, 78 }, { 252, 196, 104 }, { 255, 246, 204 }
    };
    static const unsigned char hull[3] = { 150, 178, 196 };
    unsigned colour = 0;
    int k;
    for (k = 0; k < 3; k++) {
        double at = value < 0 ? 0 : value > 1 ? 5 : value * 5, c;
        int i = at >= 5 ? 4 : (int)at;
        c = value < 0 ? hull[k] : scale[i][k] + (at - i) * (scale[i + 1][k] - scale[i][k]);
        c = c * shade + (1 - shade) * (10 + 14 * k);                 /* shadows are bluish */
        colour = colour << 8 | (unsigned)(c < 0 ? 0 : c > 255 ? 255 : c);
    }
    return colour;
}

/* Works for all finite coordinates: they are halved first, so that no difference overflows. */
static void pbwpic__frame(pbwpic__view *v)
{
    const pbw_mesh *mesh = v->mesh;
    const size_t dim = (size_t)mesh->dim, corners = (dim + 1) * mesh->simplex_count;
    size_t i, k;
    for (k = 0; k < dim; k++) {
        double low = DBL_MAX, high = -DBL_MAX;
        for (i = 0; i < corners; i++) {
            const double x = mesh->points[dim * mesh->simplices[i] + k];
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        v->middle[k] = 0.5 * low + 0.5 * high;
        v->half = fmax(v->half, 0.5 * high - 0.5 * low);
    }
}

/* Coordinate k of a point in the frame, -1 to 1. */
static double pbwpic__at(const pbwpic__view *v, size_t point, size_t k)
{
    return (0.5 * v->mesh->points[(size_t)v->mesh->dim * point + k] - 0.5 * v->middle[k]) / (0.5 * v->half);
}

static double pbwpic__size(const pbwpic__view *v, size_t simplex)    /* volume or area, up to a factor */
{
    const size_t dim = (size_t)v->mesh->dim;
    const pbw_index *corner = v->mesh->simplices + (dim + 1) * simplex;
    size_t i, k;
    double e[3][3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 1 } };
    for (i = 0; i < dim; i++) {
        for (k = 0; k < dim; k++) {
            e[i][k] = pbwpic__at(v, corner[i + 1], k) - pbwpic__at(v, corner[0], k);
        }
    }
    return fabs(e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0])
              + e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]));
}

/* Values, and the range that the colours show: all but the outer hundredths. */
static int pbwpic__values(pbwpic__view *v)
{
    const unsigned char *keep = v->options->keep;
    const size_t all = v->mesh->simplex_count + 1;
    double *sorted = (double *)pbw_memory_resize(&v->memory, NULL, 0, all, sizeof *sorted);
    size_t i, count = 0;
    if (sorted == NULL) {
        return 0;
    }
    for (i = 0; i < v->mesh->simplex_count; i++) {
        v->value[i] = log(pbwpic__size(v, i) + 1e-300);
        if (keep == NULL || keep[i]) {
            sorted[count++] = v->value[i];
        }
    }
    qsort(sorted, count, sizeof *sorted, pbwpic__compare);
    v->range[0] = count == 0 ? 0 : sorted[count / 100];
    v->range[1] = count == 0 ? 1 : sorted[count - 1 - count / 100];
    (void)pbw_memory_resize(&v->memory, sorted, all, 0, sizeof *sorted);
    return 1;
}

static double pbwpic__dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void pbwpic__cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void pbwpic__unit(double a[3])
{
    double length = sqrt(pbwpic__dot(a, a));
    int k;
    for (k = 0; k < 3; k++) {
        a[k] /= length > 0 ? length : 1;
    }
}

/* ------------------------------------------------------------------------------------------------------
   >>raster       A depth buffer, and ambient occlusion from it.
   In: faces on the screen.  Out: for each pixel the nearest face and its depth; how much of the sky a face sees.
   Holds: a pixel belongs to the face that its middle is on; of faces at one depth to the first.
   ------------------------------------------------------------------------------------------------------ */

/* Assigns a face the pixels that have their middle on it and no nearer face so far. */
static void pbwpic__raster(pbwpic__view *v, unsigned id)
{
    const pbwpic__face *f = &v->face[id];
    float x0 = f->x[0], y0 = f->y[0], ax = f->x[1] - x0, ay = f->y[1] - y0, bx = f->x[2] - x0, by = f->y[2] - y0;
    float area = ax * by - ay * bx, left = x0, right = x0, top = y0, bottom = y0;
    int i, j, k, i0, i1, j0, j1;
    for (k = 1; k < 3; k++) {
        left = f->x[k] < left ? f->x[k] : left;
        right = f->x[k] > right ? f->x[k] : right;
        top = f->y[k] < top ? f->y[k] : top;
        bottom = f->y[k] > bottom ? f->y[k] : bottom;
    }
    i0 = left < 0 ? 0 : (int)left;
    i1 = right >= PBWPIC__WIDE - 1 ? PBWPIC__WIDE - 1 : (int)right + 1;
    j0 = top < 0 ? 0 : (int)top;
    j1 = bottom >= PBWPIC__HIGH - 1 ? PBWPIC__HIGH - 1 : (int)bottom + 1;
    if (!(area < 0 || area > 0)) {
        return;
    }
    for (j = j0; j <= j1; j++) {
        for (i = i0; i <= i1; i++) {
            float dx = (float)i + 0.5f - x0, dy = (float)j + 0.5f - y0;
            float s = (dx * by - dy * bx) / area, t = (ax * dy - ay * dx) / area;
            if (s >= 0 && t >= 0 && s + t <= 1) {
                float z = f->z[0] + s * (f->z[1] - f->z[0]) + t * (f->z[2] - f->z[0]);
                size_t pixel = (size_t)j * PBWPIC__WIDE + (size_t)i;
                if (z > v->depth[pixel]) {
                    v->depth[pixel] = z;
                    v->owner[pixel] = id;
                }
            }
        }
    }
}

/* Returns the ambient occlusion of a face, 0 to 1: in 16 directions on the screen, the steepest rise of the depth
   buffer over the plane of the face (Bavoil and Sainz 2008, "Image-space horizon-based ambient occlusion"). */
static double pbwpic__hidden(const pbwpic__view *v, const pbwpic__face *f)
{
    double x = (f->x[0] + f->x[1] + f->x[2]) / 3.0, y = (f->y[0] + f->y[1] + f->y[2]) / 3.0;
    double z = (f->z[0] + f->z[1] + f->z[2]) / 3.0, sum = 0, zx, zy;
    double ax = f->x[1] - f->x[0], ay = f->y[1] - f->y[0], az = f->z[1] - f->z[0];
    double bx = f->x[2] - f->x[0], by = f->y[2] - f->y[0], bz = f->z[2] - f->z[0], area = ax * by - ay * bx;
    int direction, step;
    if (!(fabs(area) > 1e-6)) {
        return 0;
    }
    zx = (az * by - ay * bz) / area;
    zy = (ax * bz - az * bx) / area;
    for (direction = 0; direction < 16; direction++) {
        double c = cos(direction * 0.39269908), s = sin(direction * 0.39269908), slope = c * zx + s * zy, most = 0;
        double floor_slope = slope > 3 ? 3 : slope < -3 ? -3 : slope;
        for (step = 0; step < 9; step++) {
            double away = 4 * pow(1.55, step), rise;
            int i = (int)(x + c * away), j = (int)(y + s * away);
            if (i >= 0 && i < PBWPIC__WIDE && j >= 0 && j < PBWPIC__HIGH) {
                rise = (v->depth[(size_t)j * PBWPIC__WIDE + (size_t)i] - z) / away - floor_slope;
                rise *= 1 / (1 + away / 90);
                most = rise > most ? rise : most;
            }
        }
        most = most > 0.15 ? most - 0.15 : 0;
        sum += most / sqrt(1 + most * most);
    }
    return sum / 16;
}

/* ------------------------------------------------------------------------------------------------------
   >>faces        Which faces are drawn, and where on the screen.
   In: a mesh, the eye, the cut.  Out: faces with colour and shade, from the farthest to the nearest.
   Holds: in space only faces that own a pixel are drawn.
   ------------------------------------------------------------------------------------------------------ */

static int pbwpic__compare_keys(const void *a, const void *b)
{
    const pbwpic__key *x = (const pbwpic__key *)a, *y = (const pbwpic__key *)b;
    return x->z < y->z ? -1 : x->z > y->z ? 1 : (x->face > y->face) - (x->face < y->face);
}

/* A new face with the colour of a simplex, NULL if there is no memory. */
static pbwpic__face *pbwpic__add(pbwpic__view *v, size_t simplex, int hull)
{
    double span = v->range[1] > v->range[0] ? v->range[1] - v->range[0] : 1, t;
    pbwpic__face *f;
    if (!pbw_memory_grow(&v->memory, &v->face, &v->face_capacity, v->face_count, 1, sizeof *f)) {
        return NULL;
    }
    f = &v->face[v->face_count++];
    memset(f, 0, sizeof *f);
    t = (v->value[simplex] - v->range[0]) / span;
    f->value = (float)(hull ? -1 : t < 0 ? 0 : t > 1 ? 1 : t);
    f->shade = 1;
    return f;
}

static int pbwpic__faces2(pbwpic__view *v)
{
    const pbw_mesh *mesh = v->mesh;
    size_t i, k;
    for (i = 0; i < mesh->simplex_count; i++) {
        if (v->options->keep == NULL || v->options->keep[i]) {
            pbwpic__face *f = pbwpic__add(v, i, 0);
            if (f == NULL) {
                return 0;
            }
            for (k = 0; k < 3; k++) {
                f->x[k] = (float)pbwpic__at(v, mesh->simplices[3 * i + k], 0);
                f->y[k] = (float)-pbwpic__at(v, mesh->simplices[3 * i + k], 1);
            }
        }
    }
    return 1;
}

/* Middle and radius of the body, in the frame. */
static double pbwpic__extent(const pbwpic__view *v, double middle[3])
{
    double low[3] = { DBL_MAX, DBL_MAX, DBL_MAX }, high[3] = { -DBL_MAX, -DBL_MAX, -DBL_MAX }, sum = 0;
    size_t i, k;
    for (i = 0; i < 4 * v->mesh->simplex_count; i++) {
        for (k = 0; k < 3 && v->shown[i / 4]; k++) {
            const double x = pbwpic__at(v, v->mesh->simplices[i], k);
            low[k] = x < low[k] ? x : low[k];
            high[k] = x > high[k] ? x : high[k];
        }
    }
    for (k = 0; k < 3; k++) {
        middle[k] = 0.5 * low[k] + 0.5 * high[k];
        sum += (high[k] - middle[k]) * (high[k] - middle[k]);
    }
    return sqrt(sum);
}

/* Adds the faces between shown simplices and others that face the viewer. */
static int pbwpic__faces3(pbwpic__view *v)
{
    static const double usual_eye[3] = { 0.1, -0.75, 1.0 }, usual_cut[4] = { 0.5, -0.8, 0.3, 0.38 };
    const pbw_mesh *mesh = v->mesh;
    const pbwpic_options *o = v->options;
    const double *cut = pbwpic__dot(o->cut, o->cut) > 0 ? o->cut : usual_cut;
    double eye[3], right[3], up[3] = { 0, 1e-9, 1 }, light[3], middle[3], radius, distance, limit;
    size_t i, j, k;
    for (i = 0; i < mesh->simplex_count; i++) {
        v->shown[i] = o->keep == NULL || o->keep[i] != 0;
    }
    radius = pbwpic__extent(v, middle);
    distance = 4.5 * radius;
    limit = cut[3] * radius * sqrt(pbwpic__dot(cut, cut));
    memcpy(eye, pbwpic__dot(o->eye, o->eye) > 0 ? o->eye : usual_eye, sizeof eye);
    pbwpic__unit(eye);
    memcpy(up, pbwpic__dot(o->up, o->up) > 0 ? o->up : up, sizeof up);      /* from straight above: y is up */
    pbwpic__cross(up, eye, right);
    pbwpic__unit(right);
    pbwpic__cross(eye, right, up);
    for (k = 0; k < 3; k++) {
        light[k] = 0.45 * eye[k] - 0.55 * right[k] + 0.75 * up[k];
    }
    pbwpic__unit(light);
    for (i = 0; i < mesh->simplex_count; i++) {
        double centre[3] = { 0, 0, 0 };
        for (j = 0; j < 12; j++) {
            centre[j % 3] += 0.25 * (pbwpic__at(v, mesh->simplices[4 * i + j / 3], j % 3) - middle[j % 3]);
        }
        v->shown[i] = (unsigned char)(v->shown[i] && pbwpic__dot(cut, centre) > limit ? 2 : v->shown[i]);
    }
    for (i = 0; i < 4 * mesh->simplex_count; i++) {
        pbw_index other = mesh->neighbors[i];
        double corner[3][3], a[3], b[3], normal[3], to[3], lit;
        pbwpic__face *f;
        if (v->shown[i / 4] != 1 || (other != PBW_NONE && v->shown[other] == 1)) {
            continue;
        }
        for (k = 0; k < 9; k++) {
            size_t p = mesh->simplices[i - i % 4 + PBW_FACET_CORNER(i % 4, k / 3)];
            corner[k / 3][k % 3] = pbwpic__at(v, p, k % 3) - middle[k % 3];
        }
        for (k = 0; k < 3; k++) {
            a[k] = corner[1][k] - corner[0][k];
            b[k] = corner[2][k] - corner[0][k];
            to[k] = distance * eye[k] - corner[0][k];
        }
        pbwpic__cross(a, b, normal);
        pbwpic__unit(normal);
        if (!(pbwpic__dot(normal, to) > 0)) {
            continue;
        }
        f = pbwpic__add(v, i / 4, other == PBW_NONE || v->shown[other] == 0);
        if (f == NULL) {
            return 0;
        }
        lit = pbwpic__dot(normal, light);
        f->shade = (float)(f->value < 0 ? 0.44 + 0.68 * (lit > 0 ? lit : 0.15 * lit) : 0.80 + 0.25 * lit);
        for (k = 0; k < 3; k++) {
            double z = pbwpic__dot(corner[k], eye), nearby = distance / (distance - z);
            f->x[k] = (float)(pbwpic__dot(corner[k], right) * nearby);
            f->y[k] = (float)(-pbwpic__dot(corner[k], up) * nearby);
            f->z[k] = (float)z;
        }
    }
    return 1;
}

/* Moves and scales all faces so that they fill the picture. */
static void pbwpic__fit(pbwpic__view *v)
{
    double *box = v->box, low_x = box[0] = DBL_MAX, low_y = box[1] = DBL_MAX, scale;
    size_t i, k;
    box[2] = box[3] = -DBL_MAX;
    for (i = 0; i < v->face_count; i++) {
        for (k = 0; k < 3; k++) {
            box[0] = fmin(box[0], v->face[i].x[k]);
            box[1] = fmin(box[1], v->face[i].y[k]);
            box[2] = fmax(box[2], v->face[i].x[k]);
            box[3] = fmax(box[3], v->face[i].y[k]);
        }
    }
    low_x = box[0];
    low_y = box[1];
    scale = fmin((PBWPIC__WIDE - 60) / (box[2] - low_x + 1e-300), (PBWPIC__HIGH - 60) / (box[3] - low_y + 1e-300));
    for (i = 0; i < v->face_count; i++) {
        pbwpic__face *f = &v->face[i];
        for (k = 0; k < 3; k++) {
            f->x[k] = (float)(30 + (f->x[k] - low_x) * scale);
            f->y[k] = (float)(30 + (f->y[k] - low_y) * scale);
            f->z[k] = (float)(f->z[k] * scale);
        }
    }
    box[2] = 60 + (box[2] - low_x) * scale;
    box[3] = 60 + (box[3] - low_y) * scale;
}

/* Chooses the faces to draw, in 3D those with at least one pixel, and their order. */
static int pbwpic__visible(pbwpic__view *v)
{
    size_t i, pixels = v->mesh->dim == 3 ? (size_t)PBWPIC__WIDE * PBWPIC__HIGH : 0;
    v->key = (pbwpic__key *)pbw_memory_resize(&v->memory, NULL, 0, v->face_count + 1, sizeof *v->key);
    v->depth = (float *)pbw_memory_resize(&v->memory, NULL, 0, pixels + 1, sizeof *v->depth);
    v->owner = (unsigned *)pbw_memory_resize(&v->memory, NULL, 0, pixels + 1, sizeof *v->owner);
    if (v->key == NULL || v->depth == NULL || v->owner == NULL) {
        return 0;
    }
    for (i = 0; i < pixels; i++) {
        v->depth[i] = -FLT_MAX;
        v->owner[i] = PBW_NONE;
    }
    for (i = 0; i < v->face_count; i++) {
        v->key[i].face = 0;
        if (pixels != 0) {
            pbwpic__raster(v, (unsigned)i);
        }
    }
    for (i = 0; i < pixels; i++) {
        if (v->owner[i] != PBW_NONE) {
            v->key[v->owner[i]].face = 1;                            /* for now: can be seen */
        }
    }
    for (i = 0; i < v->face_count; i++) {
        pbwpic__face *f = &v->face[i];
        if (pixels == 0 || v->key[i].face == 1) {
            f->shade *= (float)(pixels == 0 ? 1 : 1 - (f->value < 0 ? 0.85 : 0.5) * pbwpic__hidden(v, f));
            v->key[v->key_count].z = f->z[0] + f->z[1] + f->z[2];
            v->key[v->key_count++].face = (unsigned)i;
        }
    }
    qsort(v->key, v->key_count, sizeof *v->key, pbwpic__compare_keys);
    return 1;
}

/* Units are tenths of pixels.  Lines get thinner where faces get smaller. */
/* ------------------------------------------------------------------------------------------------------
   >>emit         The file.
   In: a mesh, the options.  Out: the picture, or a status and a message.
   Holds: on failure nothing is held.
   ------------------------------------------------------------------------------------------------------ */

static void pbwpic__emit(void *user, FILE *file)
{
    const pbwpic__view *v = (const pbwpic__view *)user;
    double line = 0.5 * sqrt(v->box[2] * v->box[3] / (double)(v->key_count + 1));
    size_t i, k;
    fprintf(file, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\">\n"
            "<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n", 10 * v->box[2], 10 * v->box[3]);
    fprintf(file, "<g stroke=\"#101828\" stroke-opacity=\".45\" stroke-width=\"%.0f\" stroke-linejoin=\"round\">\n",
            line < 3 ? 3 : line > 12 ? 12 : line);
    for (i = 0; i < v->key_count; i++) {
        const pbwpic__face *f = &v->face[v->key[i].face];
        long x[3], y[3];
        for (k = 0; k < 3; k++) {
            x[k] = lround(10.0 * (double)f->x[k]);
            y[k] = lround(10.0 * (double)f->y[k]);
        }
        fprintf(file, "<path fill=\"#%06x\" d=\"M%ld %ldl%ld %ld %ld %ldz\"/>\n", pbwpic__colour(f->value, f->shade),
                x[0], y[0], x[1] - x[0], y[1] - y[0], x[2] - x[1], y[2] - y[1]);
    }
    fprintf(file, "</g>\n</svg>\n");
}

static void pbwpic__release(pbwpic__view *v, void *block, size_t bytes)
{
    if (block != NULL) {
        (void)pbw_memory_resize(&v->memory, block, bytes, 0, 1);
    }
}

static void pbwpic__end(pbwpic__view *v)
{
    const size_t pixels = v->mesh->dim == 3 ? (size_t)PBWPIC__WIDE * PBWPIC__HIGH : 0;
    pbwpic__release(v, v->value, (v->mesh->simplex_count + 1) * sizeof *v->value);
    pbwpic__release(v, v->shown, v->mesh->simplex_count + 1);
    pbwpic__release(v, v->face, v->face_capacity * sizeof *v->face);
    pbwpic__release(v, v->key, (v->face_count + 1) * sizeof *v->key);
    pbwpic__release(v, v->depth, (pixels + 1) * sizeof *v->depth);
    pbwpic__release(v, v->owner, (pixels + 1) * sizeof *v->owner);
}

PBWDEF pbwio_status pbwpic_write(const char *path, const pbw_mesh *mesh, const pbwpic_options *options,
                                 pbwio_error *error)
{
    static const pbwpic_options defaults = { NULL, { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0, 0 }, NULL };
    pbw_options build;
    const char *what = "out of memory";
    pbwio_status status = PBWIO_ERROR_MEMORY;
    pbwpic__view v;
    if (path == NULL || mesh == NULL || (mesh->dim != 2 && mesh->dim != 3)) {
        return pbwio__file_error(error, PBWIO_ERROR_ARGUMENT, "pbwpic_write", "no path or no mesh");
    }
    memset(&v, 0, sizeof v);
    v.mesh = mesh;
    v.options = options == NULL ? &defaults : options;
    pbw_memory_start(&v.memory, v.options->build);
    memset(&build, 0, sizeof build);
    build = v.options->build != NULL ? *v.options->build : build;
    pbw_memory_nest(&v.memory, &build);
    v.value = (double *)pbw_memory_resize(&v.memory, NULL, 0, mesh->simplex_count + 1, sizeof *v.value);
    v.shown = (unsigned char *)pbw_memory_resize(&v.memory, NULL, 0, mesh->simplex_count + 1, 1);
    if (mesh->dim == 3 && mesh->neighbors == NULL) {
        status = PBWIO_ERROR_ARGUMENT;
        what = "a picture needs neighbors, the mesh has none";
    } else if (v.value != NULL && v.shown != NULL && (pbwpic__frame(&v), pbwpic__values(&v))
               && (mesh->dim == 3 ? pbwpic__faces3(&v) : pbwpic__faces2(&v))) {
        pbwpic__fit(&v);
        if (pbwpic__visible(&v)) {
            what = NULL;
            status = pbwio_save(path, pbwpic__emit, &v, &build, error);
        }
    }
    if (what != NULL && error != NULL) {
        snprintf(error->text, sizeof error->text, "%.200s: %s", path, what);
    }
    pbwpic__end(&v);
    return status;
}
#endif /* PBW_PICTURE_IMPLEMENTATION */
