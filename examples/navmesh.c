/* navmesh.c: a shortest way through a game level: walkable triangles between boxes, A* over them, and a string pulled
   tight through the triangles it finds.
   cc -O2 -I. -Iexamples/lib examples/navmesh.c -o navmesh -lpthread -lm
   Prints expected/navmesh.txt; the exit status is 1 if the way runs through a box. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#include <stdio.h>

enum { SIDE = 12, BOXES = SIDE * SIDE, MOST = 4096 };
static double points[2 * (4 + 4 * BOXES)];
static size_t first[BOXES + 2];

static void level(void)                              /* a square, and boxes turned at random in it */
{
    unsigned state = 7, i, k;
    for (i = 0; i < BOXES + 1; i++) {
        const double x = i == 0 ? SIDE / 2.0 : (i - 1) % SIDE + 0.5, y = i == 0 ? x : (i - 1) / SIDE + 0.5;
        state = state * 1664525u + 1013904223u;
        for (k = 0; k < 4; k++) {
            const double turn = 1.5707963267948966 * (k + 0.5) + (i == 0 ? 0 : (state >> 8) * 1e-6);
            const double radius = i == 0 ? SIDE / sqrt(2.0) : 0.3 + 0.15 * (state >> 28) / 16;
            points[8 * i + 2 * k] = x + radius * cos(turn);
            points[8 * i + 2 * k + 1] = y + radius * sin(turn);
        }
        first[i + 1] = 4 * (i + 1);
    }
}

static pbw_index triangle_at(const pbw_plane *p, const double *q)
{
    pbw_index t, k;
    for (t = 0; t < p->triangle_count; t++) {
        const pbw_index *v = p->triangles + 3 * t;
        for (k = 0; k < 3 && pbw_orient2(p->points + 2 * v[k], p->points + 2 * v[(k + 1) % 3], q) >= 0; k++) {
        }
        if (k == 3) {
            return t;
        }
    }
    return PBW_NONE;
}

static double distance(const double *a, const double *b) { return hypot(a[0] - b[0], a[1] - b[1]); }
/* A* from goal to start, over the middles of edges, so that from[] leads from start to goal. */
static int search(const pbw_plane *p, const double *start, const double *goal, pbw_index *from)
{
    static double cost[MOST], at[MOST][2], open[MOST];
    const pbw_index begin = triangle_at(p, goal), end = triangle_at(p, start);
    pbw_index t, k;
    if (begin == PBW_NONE || end == PBW_NONE || p->triangle_count > MOST) {
        return 0;
    }
    for (t = 0; t < p->triangle_count; t++) {
        cost[t] = HUGE_VAL;
        from[t] = PBW_NONE;
    }
    cost[begin] = 0;
    memcpy(at[begin], goal, sizeof at[0]);
    open[begin] = 1;
    for (;;) {
        pbw_index best = PBW_NONE;
        for (t = 0; t < p->triangle_count; t++) {    /* a heap, for large levels */
            if (open[t] > 0 && (best == PBW_NONE || cost[t] + distance(at[t], start)
                                                < cost[best] + distance(at[best], start))) {
                best = t;
            }
        }
        if (best == PBW_NONE || best == end) {
            return best == end;
        }
        open[best] = 0;
        for (k = 0; k < 3; k++) {
            const pbw_index n = p->neighbors[3 * best + k];
            const double *a = p->points + 2 * p->triangles[3 * best + (k + 1) % 3];
            const double *b = p->points + 2 * p->triangles[3 * best + (k + 2) % 3];
            const double m[2] = { (a[0] + b[0]) / 2, (a[1] + b[1]) / 2 };
            const double further = cost[best] + distance(at[best], m);
            if (n != PBW_NONE && further < cost[n]) {
                cost[n] = further;
                from[n] = best;
                memcpy(at[n], m, sizeof m);
                open[n] = 1;
            }
        }
    }
}

/* Pulls a string tight through the edges between the triangles (Lee and Preparata 1984).  Returns its points. */
static size_t pull(const pbw_plane *p, const double *start, const double *goal, const pbw_index *from, double *way)
{
    static double side[2][MOST][2];                  /* right and left ends of the edges */
    size_t n = 0, count = 1, i, at[2] = { 0, 0 };
    pbw_index t, k, s;
    for (t = triangle_at(p, start); from[t] != PBW_NONE; t = from[t], n++) {
        for (k = 0; p->neighbors[3 * t + k] != from[t]; k++) {
        }
        for (s = 0; s < 2; s++) {
            memcpy(side[s][n], p->points + 2 * p->triangles[3 * t + (k + 1 + s) % 3], sizeof side[s][n]);
        }
    }
    memcpy(side[0][n], memcpy(side[1][n], goal, sizeof side[0][n]), sizeof side[0][n]);
    memcpy(way, start, sizeof side[0][n]);
    for (i = 0; i <= n; i++) {
        for (s = 0; s < 2; s++) {
            const double *apex = way + 2 * (count - 1);
            const int sign = s == 0 ? 1 : -1;
            if (sign * pbw_orient2(apex, side[s][at[s]], side[s][i]) < 0) {
                continue;                            /* this side opens: the string stays where it is */
            }
            if (sign * pbw_orient2(apex, side[1 - s][at[1 - s]], side[s][i]) > 0) {
                memcpy(way + 2 * count++, side[1 - s][at[1 - s]], sizeof side[s][i]);
                i = (at[s] = ++at[1 - s]) - 1;       /* beyond the other side: it bends there, and goes on */
                break;
            }
            at[s] = i;
        }
    }
    memcpy(way + 2 * count++, goal, sizeof side[0][n]);
    return count;
}

int main(void)
{
    static const double start[2] = { 0.02, 0.02 }, goal[2] = { SIDE - 0.02, SIDE - 0.02 };
    static double way[2 * MOST], length;
    static pbw_index from[MOST];
    pbw_plane plane = { 0 };
    size_t count, i, k, wrong = 0;
    level();
    if (pbw_plane_rings(points, first, BOXES + 1, NULL, &plane) != PBW_OK || !search(&plane, start, goal, from)) {
        puts(plane.what[0] != 0 ? plane.what : "there is no way");
        return 1;
    }
    count = pull(&plane, start, goal, from, way);
    for (i = 0; i + 1 < count; i++) {
        length += distance(way + 2 * i, way + 2 * i + 2);
        for (k = 0; k < plane.edge_count; k++) {
            const double *a = way + 2 * i, *b = a + 2, *p = plane.points, *c = p + 2 * plane.edges[2 * k];
            const double *d = p + 2 * plane.edges[2 * k + 1];
            wrong += pbw_orient2(a, b, c) * pbw_orient2(a, b, d) < 0
                  && pbw_orient2(c, d, a) * pbw_orient2(c, d, b) < 0;
        }
    }
    printf("%d boxes, %zu triangles to walk on\n", BOXES, plane.triangle_count);
    printf("a way with %zu bends, %.2f long; %.2f as the crow flies\n", count - 2, length, distance(start, goal));
    pbw_plane_free(&plane);
    return wrong != 0;
}
