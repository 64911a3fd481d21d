/* pbw_web.c: pbw.h as a WebAssembly module for index.js: one call triangulates, one fills arrays in the shape that
   JavaScript expects.  `make web` builds it.
   In: points and weights, packed, that JavaScript wrote into this module's memory.
   Out: arrays that JavaScript copies and frees at once; a status.
   In the plane the orientation of triangles and hull is that of delaunator: clockwise where y points up, counter-
   clockwise on a screen.  Halfedge e runs from triangles[e] to the next corner of its triangle. */
#define PBW_NO_THREADS
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <emscripten.h>

typedef struct web_mesh {               /* all 32 bits wide: read by index.js as one Uint32Array */
    uint32_t status, simplex_count, hull_count;
    uint32_t *simplices, *adjacent, *hull;         /* PBW_NONE has the bits of -1 */
    const uint32_t *incident, *canonical;
    pbw_mesh *mesh;
} web_mesh;

static pbw_index next_in_triangle(pbw_index e)
{
    return e % 3 == 2 ? e - 2 : e + 1;
}

/* Corners a b c of pbw.h become a c b, so that slot i, opposite to corner i, becomes halfedge turned[i]. */
static void fill_plane(const pbw_mesh *mesh, web_mesh *out)
{
    static const pbw_index turned[3] = { 1, 0, 2 };
    for (pbw_index t = 0; t < out->simplex_count; t++) {
        const pbw_index *corner = mesh->simplices + 3 * t, *neighbor = mesh->neighbors + 3 * t;
        for (pbw_index i = 0; i < 3; i++) {
            pbw_index u = neighbor[i], back = 0;
            out->simplices[3 * t + i] = corner[(3 - i) % 3];
            while (u != PBW_NONE && mesh->neighbors[3 * u + back] != t) {
                back++;
            }
            out->adjacent[3 * t + turned[i]] = u == PBW_NONE ? PBW_NONE : 3 * u + turned[back];
        }
    }
}

/* Follows the boundary from the first halfedge without an opposite; counts, and fills hull if there is one. */
static uint32_t follow_hull(const web_mesh *m, pbw_index *hull)
{
    pbw_index first = 0, e;
    uint32_t count = 0;
    while (m->adjacent[first] != PBW_NONE) {
        first++;
    }
    e = first;
    do {
        if (hull != NULL) {
            hull[count] = m->simplices[e];
        }
        count++;
        e = next_in_triangle(e);
        while (m->adjacent[e] != PBW_NONE) {
            e = next_in_triangle(m->adjacent[e]);
        }
    } while (e != first);
    return count;
}

/* Facets without a neighbour, corners counter-clockwise seen from outside; counts, and fills hull if there is one. */
static uint32_t list_hull(const pbw_mesh *mesh, pbw_index *hull)
{
    static const unsigned char facet[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 0, 1, 3 }, { 0, 2, 1 } };
    uint32_t count = 0;
    for (size_t i = 0; i < 4 * mesh->simplex_count; i++) {
        if (mesh->neighbors[i] == PBW_NONE) {
            for (int k = 0; hull != NULL && k < 3; k++) {
                hull[3 * count + (uint32_t)k] = mesh->simplices[i / 4 * 4 + facet[i % 4][k]];
            }
            count++;
        }
    }
    return count;
}

static uint32_t *new_array(size_t count)
{
    return (uint32_t *)malloc(count * sizeof(uint32_t));
}

/* Makes the arrays of a mesh that has simplices; returns whether there was memory for them. */
static int fill(const pbw_mesh *mesh, web_mesh *out)
{
    size_t corners = (size_t)mesh->dim + 1, entries = corners * mesh->simplex_count;
    out->simplex_count = (uint32_t)mesh->simplex_count;
    if ((out->simplices = new_array(entries)) == NULL || (out->adjacent = new_array(entries)) == NULL) {
        return 0;
    }
    if (mesh->dim == 2) {
        fill_plane(mesh, out);
        out->hull_count = follow_hull(out, NULL);
    } else {
        memcpy(out->simplices, mesh->simplices, entries * sizeof(uint32_t));
        memcpy(out->adjacent, mesh->neighbors, entries * sizeof(uint32_t));
        out->hull_count = list_hull(mesh, NULL);
    }
    out->hull = new_array(out->hull_count * (size_t)(mesh->dim == 2 ? 1 : 3));
    if (out->hull == NULL) {
        return 0;
    }
    return (mesh->dim == 2 ? follow_hull(out, out->hull) : list_hull(mesh, out->hull)) == out->hull_count;
}

EMSCRIPTEN_KEEPALIVE void web_free(web_mesh *out)
{
    if (out != NULL) {
        pbw_free(out->mesh);
        free(out->mesh);
        free(out->simplices);
        free(out->adjacent);
        free(out->hull);
        free(out);
    }
}

/* Frees points and weights, which are of malloc, as soon as they are read.  Returns NULL where there is no memory
   even for a status; else web_free frees it. */
EMSCRIPTEN_KEEPALIVE web_mesh *web_triangulate(int dim, double *points, double *weights, size_t count)
{
    web_mesh *out = (web_mesh *)calloc(1, sizeof *out);
    if (out != NULL && (out->mesh = (pbw_mesh *)calloc(1, sizeof *out->mesh)) != NULL) {
        out->status = (uint32_t)pbw_triangulate(dim, points, weights, count, NULL, out->mesh);
    }
    free(points);
    free(weights);
    if (out == NULL || out->mesh == NULL) {
        web_free(out);
        return NULL;
    }
    if (out->status == PBW_OK && !fill(out->mesh, out)) {
        out->status = PBW_ERROR_MEMORY;
    }
    out->incident = out->mesh->incident;
    out->canonical = out->mesh->canonical;
    return out;
}

EMSCRIPTEN_KEEPALIVE const char *web_text(int status)
{
    return pbw_status_string((pbw_status)status);
}
