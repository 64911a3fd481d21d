/* gas.c: shock tube and shear layer on a moving Voronoi mesh, by the solver in gas.h.
   cc -O2 -I. -Iexamples/lib examples/gas.c -o gas -lpthread -lm
   gas [CELLS [film.html]].  Prints expected/gas.txt; the exit status is 1 if mass, momentum or energy is not kept to
   1e-12 a frame, if the tube is not near its exact solution, or if the layer does not roll up.
   The tube is Sod's (1978, "A survey of several finite difference methods"), twice, mirrored, as the box repeats.
   The shear layer is that of McNally, Lyra and Passy (2012, "A well-posed Kelvin-Helmholtz instability test"). */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#define PBW_FILM_IMPLEMENTATION
#include "pbw_film.h"
#include "gas.h"
#include <stdio.h>

static void tube(const double place[2], double state[4])
{
    const int high = place[0] < 0.5;
    state[0] = high ? 1 : 0.125;
    state[1] = state[2] = 0;
    state[3] = high ? 1 : 0.1;
}

/* The exact density of Sod's tube, (place - diaphragm) / time away: a fan, a contact at 0.92745, a shock at 1.75216
   (Toro 2009, "Riemann solvers and numerical methods for fluid dynamics", table 4.3: p* = 0.30313, u* = 0.92745). */
static double tube_density(double speed)
{
    const double sound = sqrt(1.4), fan = 2 / 2.4 + 0.4 / 2.4 * -speed / sound;
    return speed < -sound ? 1 : speed < -0.07027 ? pow(fan, 5) : speed < 0.92745 ? 0.42632
         : speed < 1.75216 ? 0.26557 : 0.125;
}

static void shear(const double place[2], double state[4])
{
    const double y = place[1], width = 0.025, pi = 3.14159265358979;
    const double d = y < 0.5 ? y - 0.25 : 0.75 - y, side = exp(-fabs(d) / width) / 2;
    const double inner = d > 0 ? 1 - side : side;              /* 0 outside the layer, 1 inside */
    state[0] = 1 + inner;
    state[1] = 0.5 - inner;
    state[2] = 0.01 * sin(4 * pi * place[0]);
    state[3] = 2.5;
}

typedef struct show {
    gas g;
    double frame_time, end, *density;
    pbw_index *corner;
    char label[80];
    int failed;
} show;

/* The mean distance of the tubes' density from the exact one; -1 after a failure. */
static double tube_error(size_t columns)
{
    gas g = gas_lattice(columns, columns / 8, 1, 0.125, 1.4);
    double error = 0;
    if (gas_start(&g, tube) != PBW_OK || !gas_run(&g, 0.1)) {
        error = -1;
    }
    for (size_t i = 0; i < g.count && error >= 0; i++) {
        const double x = g.cells.centroids[2 * i], away = x < 0.25 ? -x : x < 0.75 ? x - 0.5 : 1 - x;
        error += 8 * g.cells.volumes[i] * fabs(g.states[i][0] - tube_density(away / g.time));
    }
    gas_free(&g);
    return error;
}

/* A frame of the film: the cells of the shear layer, coloured by density. */
static int next(void *user, pbwfilm_frame *frame)
{
    show *s = (show *)user;
    gas *g = &s->g;
    if (s->failed || g->time >= s->end) {
        return -s->failed;
    }
    s->failed = !gas_run(g, g->time + s->frame_time);
    s->corner = (pbw_index *)realloc(s->corner, g->cells.facet_count * sizeof *s->corner);
    s->failed = s->failed || s->corner == NULL || s->density == NULL;
    for (size_t f = 0; f < g->cells.facet_count && !s->failed; f++) {
        s->corner[f] = g->cells.loops[g->cells.loop_first[f]];
    }
    for (size_t i = 0; i < g->count && !s->failed; i++) {
        s->density[i] = g->states[i][0];
    }
    sprintf(s->label, "time %.2f, %lu cells", g->time, (unsigned long)g->count);
    frame->count = g->count;
    frame->first = g->cells.first;
    frame->corner = s->corner;
    frame->points = g->cells.vertices;
    frame->values = s->density;
    frame->label = s->label;
    return s->failed ? -1 : 1;
}

/* The strength of the growing wave, as the paper measures it: its mean over both layers. */
static double wave_of(const gas *g)
{
    double sine = 0, cosine = 0, all = 0;
    for (size_t i = 0; i < g->count; i++) {
        const double x = g->cells.centroids[2 * i], y = g->cells.centroids[2 * i + 1], pi = 3.14159265358979;
        const double weight = g->cells.volumes[i] * exp(-4 * pi * fabs((y < 0.5 ? y : 1 - y) - 0.25));
        sine += weight * g->states[i][2] * sin(4 * pi * x);
        cosine += weight * g->states[i][2] * cos(4 * pi * x);
        all += weight;
    }
    return 2 * hypot(sine, cosine) / all;
}

int main(int argc, char **argv)
{
    const size_t side = argc > 1 ? (size_t)sqrt(atof(argv[1])) : 48;
    const double coarse = tube_error(64), fine = tube_error(128);
    show s;
    pbwfilm_options options = { 0 };
    pbwio_error error = { "" };
    double start = 0;
    int failed = !(fine > 0 && fine < 0.65 * coarse && fine < 0.01);
    memset(&s, 0, sizeof s);
    printf("shock tube: %.4f off with 64 columns of cells, %.4f with 128\n", coarse, fine);
    s.g = gas_lattice(side, side, 1, 1, 5.0 / 3);
    s.density = (double *)malloc((s.g.count + 1) * sizeof *s.density);
    failed |= gas_start(&s.g, shear) != PBW_OK;
    start = failed ? 0 : wave_of(&s.g);
    if (argc > 2 && !failed) {
        options.title = "A shear layer rolls up";
        options.note = "Kelvin-Helmholtz instability on a moving Voronoi mesh";
        options.value_name = "density";
        options.box[0] = options.box[1] = 0.02;              /* cells at the border lie on one side only */
        options.box[2] = options.box[3] = 0.98;
        options.range[0] = 0.9;
        options.range[1] = 2.1;
        s.frame_time = 0.02;
        s.end = 2.5;
        failed |= pbwfilm_write(argv[2], &options, next, &s, &error) != PBWIO_OK;
        printf("%s", error.text);
    } else if (!failed) {
        failed |= !gas_run(&s.g, 1.5);
        printf("shear layer: the wave grew %.1f times\n", wave_of(&s.g) / start);
        failed |= !(wave_of(&s.g) > 4 * start);
    }
    gas_free(&s.g);
    free(s.corner);
    free(s.density);
    return failed;
}
