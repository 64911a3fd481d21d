/* sibson.c: smooth interpolation of scattered data: Sibson's C1 interpolant, from weights and gradients.
   cc -O2 -I. -Iexamples/lib examples/sibson.c -o sibson -lpthread -lm
   Data are z = f(x, y) at random places.  Sibson's weighted mean of the data is continuous, and smooth but at the
   data; mixed with the mean of the planes through the data it has continuous gradients, and reproduces |x|^2 where
   gradients are exact.  Prints the errors of linear interpolation and of both (expected/sibson.txt).
   Sibson 1981, "A brief description of natural neighbour interpolation". */
#define PBW_IMPLEMENTATION
#define PBW_QUERY_IMPLEMENTATION
#include "pbw_query.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { COUNT = 2000, QUERIES = 5000 };

static double next(unsigned long long *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

static double f(const double *p)
{
    return sin(5 * p[0]) * cos(4 * p[1]) + p[0] * p[1];
}

/* The gradient at each datum: of the plane through it that fits its neighbours best, by least squares with weights
   1 / distance^2. */
static void estimate_gradients(const pbw_mesh *mesh, const pbw_lists *stars, const double *z, double *gradient)
{
    for (size_t v = 0; v < mesh->point_count; v++) {
        double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0;
        for (size_t i = stars->first[v]; i < stars->first[v + 1]; i++) {
            size_t u = stars->item[i];
            double x = mesh->points[2 * u] - mesh->points[2 * v];
            double y = mesh->points[2 * u + 1] - mesh->points[2 * v + 1];
            double weight = 1 / (x * x + y * y);
            xx += weight * x * x;
            xy += weight * x * y;
            yy += weight * y * y;
            xz += weight * x * (z[u] - z[v]);
            yz += weight * y * (z[u] - z[v]);
        }
        gradient[2 * v] = (xz * yy - yz * xy) / (xx * yy - xy * xy);
        gradient[2 * v + 1] = (yz * xx - xz * xy) / (xx * yy - xy * xy);
    }
}

/* The values at one query from its weights: C0 is the weighted mean, C1 mixes that with the mean of the cones. */
static void interpolate(const pbw_mesh *mesh, const pbw_lists *w, size_t query, const double *q, const double *z,
                        const double *gradient, double *smooth0, double *smooth1)
{
    double mean = 0, cones = 0, sum = 0, alpha = 0, beta = 0;
    for (size_t j = w->first[query]; j < w->first[query + 1]; j++) {
        size_t v = w->item[j];
        double x = q[0] - mesh->points[2 * v], y = q[1] - mesh->points[2 * v + 1], d = sqrt(x * x + y * y);
        mean += w->value[j] * z[v];
        if (d > 0) {
            cones += w->value[j] / d * (z[v] + gradient[2 * v] * x + gradient[2 * v + 1] * y);
            sum += w->value[j] / d;
            alpha += w->value[j] * d;
            beta += w->value[j] * d * d;
        }
    }
    *smooth0 = *smooth1 = mean;
    if (sum > 0 && beta > 0) {
        alpha /= sum;
        *smooth1 = (alpha * mean + beta * (cones / sum)) / (alpha + beta);
    }
}

int main(void)
{
    static double points[2 * COUNT], z[COUNT], gradient[2 * COUNT], queries[2 * QUERIES];
    static const char *const names[] = { "linear", "Sibson", "Sibson C1" };
    double worst[3] = { 0, 0, 0 }, total[3] = { 0, 0, 0 };
    unsigned long long state = 1;
    pbw_mesh mesh = { 0 };
    pbw_lists stars = { 0 }, linear = { 0 }, sibson = { 0 };
    pbw_status status;
    for (int i = 0; i < COUNT; i++) {
        points[2 * i] = next(&state);
        points[2 * i + 1] = next(&state);
        z[i] = f(points + 2 * i);
    }
    for (int i = 0; i < 2 * QUERIES; i++) {
        queries[i] = 0.1 + 0.8 * next(&state);
    }
    status = pbw_triangulate(2, points, NULL, COUNT, NULL, &mesh);
    status = status != PBW_OK ? status : pbw_stars(&mesh, NULL, &stars);
    status = status != PBW_OK ? status : pbw_coordinates(&mesh, queries, QUERIES, PBW_BARYCENTRIC, NULL, &linear);
    status = status != PBW_OK ? status : pbw_coordinates(&mesh, queries, QUERIES, PBW_SIBSON, NULL, &sibson);
    if (status == PBW_OK) {
        estimate_gradients(&mesh, &stars, z, gradient);
        for (size_t i = 0; i < QUERIES; i++) {
            double value[3], unused;
            interpolate(&mesh, &linear, i, queries + 2 * i, z, gradient, &value[0], &unused);
            interpolate(&mesh, &sibson, i, queries + 2 * i, z, gradient, &value[1], &value[2]);
            for (int k = 0; k < 3; k++) {
                double error = fabs(value[k] - f(queries + 2 * i));
                worst[k] = error > worst[k] ? error : worst[k];
                total[k] += error;
            }
        }
        printf("%d data, %d queries\n", COUNT, QUERIES);
        for (int k = 0; k < 3; k++) {
            printf("%-10s mean error %.1e, worst %.1e\n", names[k], total[k] / QUERIES, worst[k]);
        }
    } else {
        printf("%s\n", pbw_status_string(status));
    }
    pbw_lists_free(&stars);
    pbw_lists_free(&linear);
    pbw_lists_free(&sibson);
    pbw_free(&mesh);
    return status != PBW_OK;
}
