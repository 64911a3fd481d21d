/* sphere_cities.c: the Voronoi diagram on a sphere: how much of the Earth is nearest to each of twenty cities.
   cc -O2 -I. examples/sphere_cities.c -o sphere_cities -lpthread -lm
   Prints expected/sphere_cities.txt; the exit status is 1 if the cells do not add up to the sphere.
   Points on a sphere: a plane that has all of them on one side cuts off a cap without points.  So the facets of their
   convex hull are the Delaunay triangles on the sphere, and their normals are the corners of the cells. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <math.h>
#include <stdio.h>

typedef struct city { const char *name; double latitude, longitude; } city;

enum { CITIES = 20 };
static const city cities[CITIES] = {
    { "Anchorage", 61.2, -149.9 }, { "Auckland", -36.8, 174.8 }, { "Berlin", 52.5, 13.4 }, { "Bogota", 4.7, -74.1 },
    { "Buenos Aires", -34.6, -58.4 }, { "Cairo", 30.0, 31.2 }, { "Cape Town", -33.9, 18.4 },
    { "Delhi", 28.6, 77.2 }, { "Honolulu", 21.3, -157.9 }, { "Jakarta", -6.2, 106.8 }, { "Lagos", 6.5, 3.4 },
    { "London", 51.5, -0.1 }, { "Mexico City", 19.4, -99.1 }, { "Moscow", 55.8, 37.6 }, { "Nairobi", -1.3, 36.8 },
    { "New York", 40.7, -74.0 }, { "Perth", -32.0, 115.9 }, { "Reykjavik", 64.1, -21.9 }, { "Tokyo", 35.7, 139.7 },
    { "Vancouver", 49.3, -123.1 } };

static double dot(const double *u, const double *v)
{
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

static void cross(const double *u, const double *v, double *result)
{
    for (int k = 0; k < 3; k++) {
        result[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    }
}

static void shorten(double *u)                       /* to length 1 */
{
    const double length = sqrt(dot(u, u));
    for (int k = 0; k < 3; k++) {
        u[k] /= length;
    }
}

/* The area of the triangle on the unit sphere, negative if clockwise (Eriksson 1990). */
static double area_of(const double *a, const double *b, const double *c)
{
    double bc[3];
    cross(b, c, bc);
    return 2 * atan2(dot(a, bc), 1 + dot(a, b) + dot(b, c) + dot(c, a));
}

int main(void)
{
    const double radius = 6371.0, turn = 3.14159265358979324 / 180;
    double points[3 * CITIES], areas[CITIES] = { 0 }, sum = 0;
    pbw_mesh mesh = { 0 };
    for (int i = 0; i < CITIES; i++) {
        points[3 * i] = cos(cities[i].latitude * turn) * cos(cities[i].longitude * turn);
        points[3 * i + 1] = cos(cities[i].latitude * turn) * sin(cities[i].longitude * turn);
        points[3 * i + 2] = sin(cities[i].latitude * turn);
    }
    if (pbw_triangulate(3, points, NULL, CITIES, NULL, &mesh) != PBW_OK) {
        return 1;
    }
    for (size_t f = 0; f < 4 * mesh.simplex_count; f++) {
        pbw_index id[3];
        double u[3], v[3], center[3];
        if (mesh.neighbors[f] != PBW_NONE) {
            continue;
        }
        for (int k = 0; k < 3; k++) {
            id[k] = mesh.simplices[f / 4 * 4 + PBW_FACET_CORNER(f % 4, k)];
        }
        for (int k = 0; k < 3; k++) {
            u[k] = points[3 * id[1] + (pbw_index)k] - points[3 * id[0] + (pbw_index)k];
            v[k] = points[3 * id[2] + (pbw_index)k] - points[3 * id[0] + (pbw_index)k];
        }
        cross(u, v, center);
        shorten(center);
        for (int k = 0; k < 3; k++) {                /* on both sides of each edge: corner, middle, center */
            const double *a = points + 3 * id[k], *b = points + 3 * id[(k + 1) % 3];
            double middle[3] = { a[0] + b[0], a[1] + b[1], a[2] + b[2] };
            shorten(middle);
            areas[id[k]] += area_of(a, middle, center);
            areas[id[(k + 1) % 3]] += area_of(middle, b, center);
        }
    }
    for (int i = 0; i < CITIES; i++) {
        sum += areas[i];
        printf("%-14s %6.2f million km2\n", cities[i].name, areas[i] * radius * radius / 1e6);
    }
    printf("together       %6.2f\n", sum * radius * radius / 1e6);
    pbw_free(&mesh);
    return !(fabs(sum / (720 * turn) - 1) < 1e-12);
}
