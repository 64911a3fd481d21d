/* draw.h: for coast.c, contour.c, breaklines.c and outlines.c: a plane mesh as an SVG picture, 1000 units wide.
   fill: a colour 0xrrggbb per triangle; lines: the width of free edges and of segments. */
#ifndef DRAW_H
#define DRAW_H
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Returns the exit status. */
static int draw(const char *path, const pbw_plane *p, const unsigned *fill, const double lines[2])
{
    double low[2] = { HUGE_VAL, HUGE_VAL }, high[2] = { -HUGE_VAL, -HUGE_VAL };
    FILE *file = fopen(path, "w");
    if (file == NULL) {
        perror(path);
        return 1;
    }
    for (size_t i = 0; i < 2 * p->point_count; i++) {
        low[i % 2] = fmin(low[i % 2], p->points[i]);
        high[i % 2] = fmax(high[i % 2], p->points[i]);
    }
    const double scale = 1000 / (high[0] - low[0]);
    fprintf(file, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-5 -5 1010 %.0f\">\n<g stroke=\"#1d3445\" "
            "stroke-width=\"%g\" stroke-linejoin=\"round\">\n", (high[1] - low[1]) * scale + 10, lines[0]);
    for (size_t i = 0; i < p->triangle_count; i++) {
        fprintf(file, "<path fill=\"#%06x\" d=\"", fill[i]);
        for (int k = 0; k < 3; k++) {
            const double *q = p->points + 2 * p->triangles[3 * i + (size_t)k];
            fprintf(file, "%c%.2f %.2f", k == 0 ? 'M' : 'L', (q[0] - low[0]) * scale, (high[1] - q[1]) * scale);
        }
        fputs("z\"/>\n", file);
    }
    fprintf(file, "</g>\n<path fill=\"none\" stroke=\"#10202c\" stroke-width=\"%g\" stroke-linecap=\"round\" d=\"",
            lines[1]);
    for (size_t i = 0; i < 2 * p->edge_count; i++) {
        const double *q = p->points + 2 * p->edges[i];
        fprintf(file, "%c%.2f %.2f\n", i % 2 == 0 ? 'M' : 'L', (q[0] - low[0]) * scale, (high[1] - q[1]) * scale);
    }
    fputs("\"/>\n</svg>\n", file);
    const int failed = ferror(file);
    if (fclose(file) != 0 || failed) {
        fprintf(stderr, "%s: could not be written\n", path);
        return 1;
    }
    return 0;
}

/* A colour between two, t from 0 to 1. */
static unsigned blend(unsigned one, unsigned other, double t)
{
    unsigned colour = 0;
    for (int shift = 16; shift >= 0; shift -= 8) {
        const double a = one >> shift & 255, b = other >> shift & 255;
        colour = colour << 8 | (unsigned)(a + fmin(fmax(t, 0), 1) * (b - a));
    }
    return colour;
}

#endif
