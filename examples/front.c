/* front.c: a disc in a swirling flow, on a mesh that follows its edge, by front.h: error against degrees of freedom.
   cc -O2 -I. -Iexamples/lib examples/front.c -o front -lpthread -lm
   front [film.html].  Prints expected/front.txt, and numbers on the error stream; the exit status is 1 if the error
   does not fall as 1 / points, as linear interpolation does where points are well placed, or if a fixed grid of
   that many points is not five times as far off. */
#define PBW_IMPLEMENTATION
#define PBW_QUERY_IMPLEMENTATION
#include "pbw_query.h"
#define PBW_LIVE_IMPLEMENTATION
#include "pbw_live.h"
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#define PBW_FILM_IMPLEMENTATION
#include "pbw_film.h"
#include "front.h"
#include <stdio.h>

enum { STEPS = 16, SIDE = 12, GRID = 256 };
static const double end = 1;                         /* when the exact solution is the first one again */

static double disc(const double *p)
{
    return 0.5 + 0.5 * tanh((0.15 - hypot(p[0] - 0.5, p[1] - 0.75)) / 0.02);
}

/* The root of the mean square of the error at time 0 or 1, at the places of a grid; -1 after a failure. */
static double error_of(const front *f)
{
    double *place = (double *)malloc(2 * GRID * GRID * sizeof *place), *value = (double *)malloc(GRID * GRID
                  * sizeof *value), sum = -1;
    for (size_t i = 0; i < GRID * GRID && place != NULL; i++) {
        place[2 * i] = ((double)(i % GRID) + 0.5) / GRID;
        place[2 * i + 1] = ((double)(i / GRID) + 0.5) / GRID;
    }
    if (place != NULL && value != NULL && front_read(&f->now, place, GRID * GRID, value) == PBW_OK) {
        sum = 0;
        for (size_t i = 0; i < GRID * GRID; i++) {
            const double off = value[i] - disc(place + 2 * i);
            sum += off * off;
        }
    }
    free(place);
    free(value);
    return sum < 0 ? -1 : sqrt(sum / (GRID * GRID));
}

static size_t points_of(const front *f)
{
    size_t count = 0;
    for (size_t i = 0; i < f->now.mesh.point_count; i++) {
        count += f->now.mesh.canonical[i] == i;
    }
    return count;
}

/* The error at the end, and the mean number of points on the way there. */
static double run(size_t side, double tolerance, double *points)
{
    front f;
    pbw_status status = front_start(&f, side, disc, tolerance);
    double error = -1;
    *points = 0;
    for (int i = 0; i < STEPS && status == PBW_OK; i++) {
        status = front_step(&f, end / STEPS, tolerance);
        *points += (double)points_of(&f) / STEPS;
    }
    error = status == PBW_OK ? error_of(&f) : -1;
    if (error < 0) {
        printf("%s\n", pbw_status_string(status));
    }
    front_free(&f);
    fprintf(stderr, "%7.0f points: %.5f off%s\n", *points, error, tolerance < HUGE_VAL ? "" : " (a fixed grid)");
    return error;
}

/* ---- the film */

typedef struct show { front f; double *value, step, tolerance; char label[80]; int failed; } show;

static int next(void *user, pbwfilm_frame *frame)
{
    show *s = (show *)user;
    const pbw_mesh *m = &s->f.now.mesh;
    if (s->failed || s->f.time > end - s->step / 2) {
        return -s->failed;
    }
    s->failed = front_step(&s->f, s->step, s->tolerance) != PBW_OK;
    s->value = (double *)realloc(s->value, (m->simplex_count + 1) * sizeof *s->value);
    s->failed |= s->value == NULL;
    for (size_t t = 0; t < m->simplex_count && !s->failed; t++) {
        const pbw_index *v = m->simplices + 3 * t;
        s->value[t] = (s->f.now.value[v[0]] + s->f.now.value[v[1]] + s->f.now.value[v[2]]) / 3;
    }
    sprintf(s->label, "time %.2f, %lu points", s->f.time, (unsigned long)points_of(&s->f));
    frame->count = m->simplex_count;
    frame->corners = 3;
    frame->corner = m->simplices;
    frame->points = m->points;
    frame->values = s->value;
    frame->label = s->label;
    return s->failed ? -1 : 1;
}

static int film(const char *path)                    /* returns whether it is written */
{
    pbwfilm_options options = { 0 };
    pbwio_error error = { "" };
    show s;
    int written;
    memset(&s, 0, sizeof s);
    s.step = end / 64;
    s.tolerance = 0.008;
    s.failed = front_start(&s.f, SIDE, disc, s.tolerance) != PBW_OK;
    options.title = "A disc in a swirling flow";
    options.note = "A triangulation that lives: points are inserted where the error is large, and removed behind it";
    options.value_name = "u";
    options.box[2] = options.box[3] = options.range[1] = 1;
    written = pbwfilm_write(path, &options, next, &s, &error) == PBWIO_OK;
    printf("%s", error.text);
    front_free(&s.f);
    free(s.value);
    return written;
}

int main(int argc, char **argv)
{
    double points[4], error[4], slope;
    if (argc > 1) {
        return !film(argv[1]);
    }
    for (int i = 0; i < 3; i++) {
        error[i] = run(SIDE, 0.02 / pow(3, i), points + i);
    }
    error[3] = run((size_t)sqrt(points[2]), HUGE_VAL, points + 3);
    slope = log(error[2] / error[0]) / log(points[2] / points[0]);
    printf("the error falls as points to the power of %.1f\n", slope);
    printf("a fixed grid of the most points is %s as far off\n",
           error[3] > 5 * error[2] ? "more than five times" : "not five times");
    return !(error[0] > 0 && error[1] > 0 && error[2] > 0 && slope < -0.9 && error[3] > 5 * error[2]);
}
