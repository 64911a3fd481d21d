/* vertices.c: the positions in a game's vertex buffer, triangulated where they lie; the result is an index buffer.
   cc -O2 -I. examples/vertices.c -o vertices -lpthread -lm
   Floats with a stride in, 32-bit indices out, counter-clockwise and in an order that suits a GPU's vertex cache.
   Prints the counts of expected/vertices.txt. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>
#include <math.h>

typedef struct vertex {
    float position[3], normal[3], uv[2];
    unsigned char color[4];
} vertex;

enum { SIDE = 100, COUNT = SIDE * SIDE, CACHE = 32 };

static vertex vertices[COUNT];

/* Misses a triangle of a first-in first-out cache of CACHE vertices; no order can be below 0.5 by much. */
static double misses(const pbw_index *indices, size_t triangles)
{
    static size_t entered[COUNT];      /* the miss at which each vertex came in; 0 never */
    size_t count = 0;
    for (size_t i = 0; i < 3 * triangles; i++) {
        size_t *in = entered + indices[i];
        if (*in == 0 || *in + CACHE <= count) {
            *in = ++count;
        }
    }
    return (double)count / (double)triangles;
}

/* Smooth normals: the sum of the triangles' normals, which are as long as twice their areas. */
static void set_normals(const pbw_index *indices, size_t triangles)
{
    for (size_t i = 0; i < triangles; i++) {
        const pbw_index *c = indices + 3 * i;
        const float *a = vertices[c[0]].position, *b = vertices[c[1]].position, *d = vertices[c[2]].position;
        const float u[3] = { b[0] - a[0], b[1] - a[1], b[2] - a[2] };
        const float v[3] = { d[0] - a[0], d[1] - a[1], d[2] - a[2] };
        for (int k = 0; k < 3; k++) {
            float *n = vertices[c[k]].normal;
            n[0] += u[1] * v[2] - u[2] * v[1];
            n[1] += u[2] * v[0] - u[0] * v[2];
            n[2] += u[0] * v[1] - u[1] * v[0];
        }
    }
    for (int i = 0; i < COUNT; i++) {
        float *n = vertices[i].normal, length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        n[0] /= length, n[1] /= length, n[2] /= length;
    }
}

int main(void)
{
    unsigned long long state = 1;
    pbw_options options = { 0 };
    pbw_mesh ground = { 0 }, cloud = { 0 };
    pbw_status status;
    float lowest = 1;
    for (int i = 0; i < COUNT; i++) {
        float *p = vertices[i].position;
        for (int k = 0; k < 2; k++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            p[k] = (float)((k == 0 ? i % SIDE : i / SIDE) + (double)(state >> 40) / 16777216.0) / SIDE;
        }
        p[2] = p[0] * p[1] * (1 - p[0]);
    }
    options.stride = sizeof(vertex);
    status = pbw_triangulatef(2, vertices[0].position, NULL, COUNT, &options, &ground);        /* reads x and y */
    if (status == PBW_OK) {
        status = pbw_triangulatef(3, vertices[0].position, NULL, COUNT, &options, &cloud);     /* reads x, y and z */
    }
    if (status != PBW_OK) {
        printf("%s\n", pbw_status_string(status));
        return 1;
    }
    set_normals(ground.simplices, ground.simplex_count);
    for (int i = 0; i < COUNT; i++) {
        lowest = vertices[i].normal[2] < lowest ? vertices[i].normal[2] : lowest;
    }
    printf("%d vertices of %zu bytes\n", COUNT, sizeof(vertex));
    printf("2D: an index buffer of %zu triangles, %.2f cache misses a triangle, all normals up: %s\n",
           ground.simplex_count, misses(ground.simplices, ground.simplex_count), lowest > 0 ? "yes" : "no");
    printf("3D: %zu tetrahedra\n", cloud.simplex_count);
    pbw_free(&ground);
    pbw_free(&cloud);
    return 0;
}
