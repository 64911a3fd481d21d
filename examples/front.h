/* front.h: a front that a flow carries along, on a mesh that follows it by its errors.
   The equation is du/dt + v . grad u = 0 in the unit square; u is linear on triangles.  A step is semi-Lagrangian:
   the new value at a place is the old one where the flow was a step ago, which pbw_coordinates finds in the old mesh.
   The new mesh is the old one with points inserted where linear interpolation of the new values errs by more than a
   tolerance, and removed where it errs by much less; one pbw_live carries both out. */
#ifndef FRONT_H
#define FRONT_H
#include "pbw_live.h"
#include "pbw_query.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct front_field { pbw_mesh mesh; double *value; } front_field;      /* a value for each number */

typedef struct front {
    pbw_live *live;
    front_field now, past;
    size_t kept;                           /* the first points are never removed: the square stays covered */
    double time;
} front;

static void front_free_field(front_field *f)
{
    pbw_free(&f->mesh);
    free(f->value);
    f->value = NULL;
}

static void front_free(front *f)
{
    front_free_field(&f->now);
    front_free_field(&f->past);
    pbw_live_free(f->live);
    f->live = NULL;
}

/* The swirling flow of LeVeque (1996, "High-resolution conservative algorithms for advection in incompressible flow",
   section 9.5), turned round so that at time 1 everything is back at its place. */
static void front_flow(double time, const double p[2], double v[2])
{
    const double pi = 3.14159265358979, turn = cos(pi * time), s = sin(pi * p[0]), t = sin(pi * p[1]);
    v[0] = -turn * s * s * sin(2 * pi * p[1]);
    v[1] = turn * t * t * sin(2 * pi * p[0]);
}

/* Where the flow was at `time`, of what is at a place at time + step: four steps backwards of the classical
   Runge-Kutta method. */
static void front_foot(double time, double step, const double place[2], double foot[2])
{
    static const double share[4] = { 0, 0.5, 0.5, 1 }, weight[4] = { 1 / 6.0, 1 / 3.0, 1 / 3.0, 1 / 6.0 };
    const double quarter = step / 4;
    memcpy(foot, place, 2 * sizeof *foot);
    for (int part = 0; part < 4; part++) {
        const double from = time + step - part * quarter;
        double v[2] = { 0, 0 }, sum[2] = { 0, 0 };
        for (int i = 0; i < 4; i++) {
            const double at[2] = { foot[0] - share[i] * quarter * v[0], foot[1] - share[i] * quarter * v[1] };
            front_flow(from - share[i] * quarter, at, v);
            sum[0] += weight[i] * v[0];
            sum[1] += weight[i] * v[1];
        }
        foot[0] = fmin(fmax(foot[0] - quarter * sum[0], 0), 1);
        foot[1] = fmin(fmax(foot[1] - quarter * sum[1], 0), 1);
    }
}

/* The values of a field at places in the square. */
static pbw_status front_read(const front_field *f, const double *places, size_t count, double *out)
{
    pbw_lists lists = { 0 };
    const pbw_status status = pbw_coordinates(&f->mesh, places, count, PBW_BARYCENTRIC, NULL, &lists);
    for (size_t i = 0; i < count && status == PBW_OK; i++) {
        out[i] = 0;
        for (size_t j = lists.first[i]; j < lists.first[i + 1]; j++) {
            out[i] += lists.value[j] * f->value[lists.item[j]];
        }
    }
    pbw_lists_free(&lists);
    return status;
}

/* New values of places, from the field of the past.  initial: what they are at time 0, where there is no past. */
typedef struct front_source { double (*initial)(const double *place); double step; } front_source;

static pbw_status front_values(const front *f, const front_source *from, const double *places, size_t count,
                               double *out)
{
    double *feet = (double *)malloc((2 * count + 1) * sizeof *feet);
    pbw_status status = feet == NULL ? PBW_ERROR_MEMORY : PBW_OK;
    for (size_t i = 0; i < count && from->initial != NULL; i++) {
        out[i] = from->initial(places + 2 * i);
    }
    if (status == PBW_OK && from->initial == NULL) {
        for (size_t i = 0; i < count; i++) {
            front_foot(f->time, from->step, places + 2 * i, feet + 2 * i);
        }
        status = front_read(&f->past, feet, count, out);
    }
    free(feet);
    return status;
}

/* The gradient at each point: the mean over its triangles, by area. */
static void front_gradients(const front_field *f, double (*gradient)[2], double *area)
{
    memset(gradient, 0, f->mesh.point_count * sizeof *gradient);
    memset(area, 0, f->mesh.point_count * sizeof *area);
    for (size_t t = 0; t < f->mesh.simplex_count; t++) {
        const pbw_index *v = f->mesh.simplices + 3 * t;
        const double *p[3], *u = f->value;
        for (int k = 0; k < 3; k++) {
            p[k] = f->mesh.points + 2 * (size_t)v[k];
        }
        const double twice = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
        double sum[2] = { 0, 0 };          /* the gradient times twice the area */
        for (int k = 0; k < 3; k++) {
            const double *a = p[(k + 1) % 3], *b = p[(k + 2) % 3];
            sum[0] += u[v[k]] * (a[1] - b[1]);
            sum[1] += u[v[k]] * (b[0] - a[0]);
        }
        for (int k = 0; k < 3; k++) {
            gradient[v[k]][0] += sum[0];
            gradient[v[k]][1] += sum[1];
            area[v[k]] += twice;
        }
    }
    for (size_t i = 0; i < f->mesh.point_count; i++) {
        gradient[i][0] /= area[i] > 0 ? area[i] : 1;
        gradient[i][1] /= area[i] > 0 ? area[i] : 1;
    }
}

typedef struct front_changes { double *points; pbw_index *leave; size_t points_count, leave_count; } front_changes;

/* What to change.  Amid an edge from a to b interpolation errs by |(grad u(b) - grad u(a)) . (b - a)| / 8,
   exactly so where u is quadratic: the middle is inserted if that is above the tolerance.  A point is removed if its
   edges err by less than an eighth of that, since edges twice as long err four times as much; of neighbours, the
   first. */
static pbw_status front_plan(const front *f, double tolerance, front_changes *changes)
{
    const pbw_mesh *m = &f->now.mesh;
    const size_t count = m->point_count;
    double (*gradient)[2] = (double (*)[2])malloc((count + 1) * sizeof *gradient);
    double *area = (double *)malloc((count + 1) * sizeof *area), *worst = (double *)calloc(count + 1, sizeof *worst);
    pbw_lists stars = { 0 };
    pbw_status status = gradient == NULL || area == NULL || worst == NULL ? PBW_ERROR_MEMORY
                      : pbw_stars(m, NULL, &stars);
    if (status == PBW_OK) {
        front_gradients(&f->now, gradient, area);
    }
    for (size_t i = 0; i < 3 * m->simplex_count && status == PBW_OK; i++) {
        const pbw_index a = m->simplices[i - i % 3 + (i + 1) % 3], b = m->simplices[i - i % 3 + (i + 2) % 3];
        const double *p = m->points + 2 * (size_t)a, *q = m->points + 2 * (size_t)b;
        const double error = fabs((gradient[b][0] - gradient[a][0]) * (q[0] - p[0])
                                + (gradient[b][1] - gradient[a][1]) * (q[1] - p[1])) / 8;
        worst[a] = fmax(worst[a], error);
        worst[b] = fmax(worst[b], error);
        if (error > tolerance && i / 3 < m->neighbors[i]) {          /* once; PBW_NONE is larger than all */
            changes->points[2 * changes->points_count] = (p[0] + q[0]) / 2;
            changes->points[2 * changes->points_count++ + 1] = (p[1] + q[1]) / 2;
        }
    }
    for (size_t i = f->kept; i < count && status == PBW_OK; i++) {
        int leaves = m->incident[i] != PBW_NONE && worst[i] < tolerance / 8;
        for (size_t j = stars.first[i]; j < stars.first[i + 1] && leaves; j++) {
            leaves = worst[stars.item[j]] < HUGE_VAL;
        }
        if (leaves) {
            worst[i] = HUGE_VAL;           /* it leaves */
            changes->leave[changes->leave_count++] = (pbw_index)i;
        }
    }
    pbw_lists_free(&stars);
    free(gradient);
    free(area);
    free(worst);
    return status;
}

/* The view after a commit, with room for the values of its points; those of points that stay are kept. */
static pbw_status front_look(front *f)
{
    double *more;
    pbw_status status = pbw_live_commit(f->live, NULL);
    pbw_free(&f->now.mesh);
    status = status != PBW_OK ? status : pbw_live_view(f->live, &f->now.mesh);
    more = status != PBW_OK ? NULL : (double *)realloc(f->now.value, (f->now.mesh.point_count + 1) * sizeof *more);
    f->now.value = more != NULL ? more : f->now.value;
    return status == PBW_OK && more == NULL ? PBW_ERROR_MEMORY : status;
}

/* One round of changes; *inserted: how many points more. */
static pbw_status front_round(front *f, const front_source *from, double tolerance, size_t *inserted)
{
    const size_t corners = 3 * f->now.mesh.simplex_count + 1;
    front_changes changes = { 0 };
    pbw_index *ids = (pbw_index *)malloc(corners * sizeof *ids);
    double *value = (double *)malloc(corners * sizeof *value);
    pbw_status status = PBW_ERROR_MEMORY;
    changes.points = (double *)malloc(2 * corners * sizeof *changes.points);
    changes.leave = (pbw_index *)malloc(corners * sizeof *changes.leave);
    if (ids != NULL && value != NULL && changes.points != NULL && changes.leave != NULL) {
        status = front_plan(f, tolerance, &changes);
    }
    status = status != PBW_OK ? status : pbw_live_remove(f->live, changes.leave, changes.leave_count);
    status = status != PBW_OK ? status : pbw_live_insert(f->live, changes.points, NULL, changes.points_count, ids);
    status = status != PBW_OK ? status : front_look(f);
    status = status != PBW_OK ? status : front_values(f, from, changes.points, changes.points_count, value);
    for (size_t i = 0; i < changes.points_count && status == PBW_OK; i++) {
        f->now.value[ids[i]] = value[i];
    }
    *inserted = changes.points_count;
    free(ids);
    free(value);
    free(changes.points);
    free(changes.leave);
    return status;
}

/* Rounds until no edge errs by more than the tolerance, a dozen at most; none if that is HUGE_VAL. */
static pbw_status front_adapt(front *f, const front_source *from, double tolerance)
{
    pbw_status status = PBW_OK;
    size_t inserted = tolerance < HUGE_VAL;
    for (int i = 0; i < 12 && status == PBW_OK && inserted > 0; i++) {
        status = front_round(f, from, tolerance, &inserted);
    }
    return status;
}

/* A front at time 0 on a grid of side by side squares, then refined.  front_free it, also after a failure. */
static pbw_status front_start(front *f, size_t side, double (*initial)(const double *), double tolerance)
{
    const front_source from = { initial, 0 };
    double *grid = (double *)malloc(2 * (side + 1) * (side + 1) * sizeof *grid);
    pbw_status status = grid == NULL ? PBW_ERROR_MEMORY : PBW_OK;
    memset(f, 0, sizeof *f);
    f->kept = (side + 1) * (side + 1);
    for (size_t i = 0; i < f->kept && status == PBW_OK; i++) {
        grid[2 * i] = (double)(i % (side + 1)) / (double)side;
        grid[2 * i + 1] = (double)(i / (side + 1)) / (double)side;
    }
    status = status != PBW_OK ? status : pbw_triangulate(2, grid, NULL, f->kept, NULL, &f->now.mesh);
    status = status != PBW_OK ? status : pbw_live_create(&f->now.mesh, NULL, &f->live);
    status = status != PBW_OK ? status : front_look(f);
    status = status != PBW_OK ? status : front_values(f, &from, grid, f->kept, f->now.value);
    free(grid);
    return status != PBW_OK ? status : front_adapt(f, &from, tolerance);
}

/* A step in time; a tolerance of HUGE_VAL leaves the mesh alone. */
static pbw_status front_step(front *f, double step, double tolerance)
{
    const front_source from = { NULL, step };
    pbw_status status;
    front_free_field(&f->past);
    f->past = f->now;
    memset(&f->now, 0, sizeof f->now);
    status = front_look(f);
    status = status != PBW_OK ? status : front_values(f, &from, f->now.mesh.points, f->now.mesh.point_count,
                                                      f->now.value);
    status = status != PBW_OK ? status : front_adapt(f, &from, tolerance);
    f->time += step;
    return status;
}
#endif /* FRONT_H */
