/* swarm.c: points that all move, frame by frame, with areas and centroids of their cells, by swarm.h.
   cc -O2 -I. -Iexamples/lib examples/swarm.c -o swarm -lpthread -lm
   swarm [POINTS FRAMES [film.html]].  Prints expected/swarm.txt, and on the error stream how long frames took; the
   exit status is 1 if the cells of a frame do not add up to the box, or if a 100th frame has another triangulation,
   by its hash, than pbw_triangulate makes of its points, or other cells than pbw_cells_of. */
#define PBW_IMPLEMENTATION
#define PBW_LIVE_IMPLEMENTATION
#include "pbw_live.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#define PBW_FILM_IMPLEMENTATION
#include "pbw_film.h"
#include "swarm.h"
#include <stdio.h>
#include <sys/time.h>

enum { SHOWN = 150 };                                /* frames of the film */

typedef struct show {
    swarm s;
    size_t frames, frame, rebuilds;
    double *dye, *seconds;                           /* where each point was at first; how long each frame took */
    pbw_cells cells;                                 /* of a frame of the film */
    pbw_index *corner;
    char label[80];
    int failed;
} show;

static double now(void)
{
    struct timeval t;
    gettimeofday(&t, NULL);
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}

/* Whether the cells fill the box, and every 100th frame is that of a rebuild. */
static int is_right(show *w)
{
    double sum = 0;
    for (size_t i = 0; i < w->s.count; i++) {
        sum += w->s.areas[i];
    }
    w->rebuilds += w->frame % 100 == 0;
    return fabs(sum / 2 - 1) < 1e-12 && (w->frame % 100 != 0 || swarm_is_exact(&w->s));
}

static void run_frame(show *w)
{
    const double start = now();
    const pbw_status status = swarm_frame(&w->s);
    w->seconds[w->frame++] = now() - start;
    if (status != PBW_OK || !is_right(w)) {
        printf("frame %lu: %s\n", (unsigned long)w->frame, status != PBW_OK ? pbw_status_string(status) : "wrong");
        w->failed = 1;
    }
}

/* A frame of the film, which has 150 of them: the cells, coloured by where their points were at first. */
static int next(void *user, pbwfilm_frame *frame)
{
    show *w = (show *)user;
    const pbw_cells *c = &w->cells;
    const size_t each = w->frames < SHOWN ? 1 : w->frames / SHOWN;
    if (w->failed || w->frame + each > w->frames) {
        return -w->failed;
    }
    for (size_t i = 1; i <= each && !w->failed; i++) {
        run_frame(w);
    }
    pbw_cells_free(&w->cells);
    w->failed = w->failed || swarm_shapes(&w->s, PBW_CELLS_SHAPES, &w->cells) != PBW_OK;
    w->corner = (pbw_index *)realloc(w->corner, (c->facet_count + 1) * sizeof *w->corner);
    w->failed |= w->corner == NULL;
    for (size_t f = 0; f < c->facet_count && !w->failed; f++) {
        w->corner[f] = c->loops[c->loop_first[f]];
    }
    sprintf(w->label, "frame %lu, time %.2f, %lu cells", (unsigned long)w->frame, w->s.time,
            (unsigned long)w->s.count);
    frame->count = w->s.count;
    frame->first = c->first;
    frame->corner = w->corner;
    frame->points = c->vertices;
    frame->values = w->dye;
    frame->label = w->label;
    return w->failed ? -1 : 1;
}

static int film(show *w, const char *path)           /* returns whether it is written */
{
    pbwfilm_options options = { 0 };
    pbwio_error error = { "" };
    options.title = "A swarm in a double gyre";
    options.note = "Voronoi cells of points that all move";
    options.value_name = "x at first";
    options.box[2] = options.range[1] = 2;
    options.box[3] = 1;
    const int written = pbwfilm_write(path, &options, next, w, &error) == PBWIO_OK;
    printf("%s", error.text);
    return written;
}

static int ascending(const void *a, const void *b)
{
    return (*(const double *)a > *(const double *)b) - (*(const double *)a < *(const double *)b);
}

static void report(show *w)
{
    const double *t = w->seconds;
    qsort(w->seconds, w->frame, sizeof *t, ascending);
    printf("%lu points: %lu frames; a rebuild of %lu of them was equal\n", (unsigned long)w->s.count,
           (unsigned long)w->frame, (unsigned long)w->rebuilds);
    fprintf(stderr, "milliseconds a frame: %.2f (median), %.2f (90 %%), %.2f (99 %%), %.2f (the slowest)\n",
            1e3 * t[w->frame / 2], 1e3 * t[w->frame * 9 / 10], 1e3 * t[w->frame * 99 / 100], 1e3 * t[w->frame - 1]);
}

int main(int argc, char **argv)
{
    show w;
    memset(&w, 0, sizeof w);
    const size_t count = argc > 1 ? (size_t)atof(argv[1]) : 2000;
    w.frames = argc > 2 ? (size_t)atof(argv[2]) : 300;
    w.dye = (double *)malloc((count + 1) * sizeof *w.dye);
    w.seconds = (double *)calloc(w.frames + 1, sizeof *w.seconds);
    w.failed = w.dye == NULL || w.seconds == NULL || swarm_start(&w.s, count, 1) != PBW_OK;
    for (size_t i = 0; i < count && !w.failed; i++) {
        w.dye[i] = w.s.points[2 * i];
    }
    if (argc > 3) {
        w.failed |= w.failed || !film(&w, argv[3]);
    }
    while (argc <= 3 && !w.failed && w.frame < w.frames) {
        run_frame(&w);
    }
    if (!w.failed) {
        report(&w);
    }
    swarm_free(&w.s);
    pbw_cells_free(&w.cells);
    free(w.dye);
    free(w.seconds);
    free(w.corner);
    return w.failed;
}
