/* lowpoly.c: a picture as a few thousand triangles: points where it has detail, Delaunay, one colour a triangle.
   cc -O2 -I. examples/lowpoly.c -o lowpoly -lpthread -lm
   lowpoly in.ppm out.svg does it to a picture of yours; without arguments it paints one into a PPM file and reads
   that.  Prints how well the triangles show it: expected/lowpoly.txt. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>
#include <stdlib.h>

enum { POINTS = 3000 };

typedef struct image { int width, height, most; unsigned char *rgb; } image;

/* Hills before an evening sky, as a binary PPM file. */
static void paint(FILE *file, int width, int height)
{
    fprintf(file, "P6\n# hills\n%d %d\n255\n", width, height);
    for (int i = 0; i < width * height; i++) {
        int x = i % width, y = i / width, u = x - 2 * width / 3, v = y - height / 3, far = x % 120, near = x % 190;
        int color = y > 270 - near * (190 - near) / 150 ? 0x285532 : y > 200 - far * (120 - far) / 60 ? 0x5a4b78 :
                    u * u + v * v < 900 ? 0xfff0b4 : 0xd79682;
        for (int k = 16; k >= 0; k -= 8) {
            putc((color >> k & 255) - y / 16, file);
        }
    }
    rewind(file);
}

/* A binary PPM file of 8 bits a channel; rgb is NULL if it is none, or too large. */
static image read_ppm(FILE *file)
{
    image p = { 0, 0, 0, NULL };
    int *const number[3] = { &p.width, &p.height, &p.most };
    for (int k = 0; k < 3; k++) {      /* a line of comment may precede a number */
        if ((k == 0 && (getc(file) != 'P' || getc(file) != '6')) || fscanf(file, " #%*[^\n]") == EOF ||
            fscanf(file, "%5d", number[k]) != 1) {
            return p;
        }
    }
    getc(file);
    if (p.width >= 2 && p.width <= 20000 && p.height >= 2 && p.height <= 20000 && p.most == 255) {
        size_t pixels = (size_t)p.width * (size_t)p.height;
        p.rgb = (unsigned char *)calloc(pixels, 3);
        if (p.rgb != NULL && fread(p.rgb, 3, pixels, file) != pixels) {
            free(p.rgb);
            p.rgb = NULL;
        }
    }
    return p;
}

/* The four corners, then pixels at random: one with a strong edge is taken more readily. */
static void choose_points(const image *p, double *points)
{
    unsigned long long state = 1;
    for (int count = 0; count < POINTS;) {
        int x = count % 2 * (p->width - 1), y = count / 2 * (p->height - 1), edge = 255;
        if (count >= 4) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            x = (int)(state >> 40) % (p->width - 1);
            y = (int)(state >> 16 & 0xffffff) % (p->height - 1);
            for (int k = edge = 0; k < 3; k++) {
                const unsigned char *q = p->rgb + 3 * (y * p->width + x) + k;
                edge += abs(q[3] - q[0]) + abs(q[3 * p->width] - q[0]);
            }
        }
        if (edge + 2 > (int)(state >> 10 & 63)) {
            points[2 * count] = x + 0.5;
            points[2 * count++ + 1] = y + 0.5;
        }
    }
}

static int write_svg(const char *name, const image *p, const pbw_mesh *mesh, long (*sums)[4])
{
    FILE *file = fopen(name, "w");
    if (file == NULL) {
        return 0;
    }
    fprintf(file, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\">\n", p->width, p->height);
    for (size_t i = 0; i < mesh->simplex_count; i++) {
        const pbw_index *t = mesh->simplices + 3 * i;
        const double *a = mesh->points + 2 * t[0], *b = mesh->points + 2 * t[1], *c = mesh->points + 2 * t[2];
        fprintf(file, "<path d=\"M%g %gL%g %gL%g %gZ\" fill=\"#%02lx%02lx%02lx\"/>\n", a[0], a[1], b[0], b[1], c[0],
                c[1], sums[i][0] / sums[i][3], sums[i][1] / sums[i][3], sums[i][2] / sums[i][3]);
    }
    fprintf(file, "</svg>\n");
    return fclose(file) == 0;
}

int main(int argc, char **argv)
{
    static double points[2 * POINTS];
    FILE *in = argc == 3 ? fopen(argv[1], "rb") : tmpfile();
    image p = { 0, 0, 0, NULL };
    pbw_mesh mesh = { 0 };
    pbw_status status;
    pbw_index *triangle_of, t = 0;
    long (*sums)[4], off = 0;          /* sums, per triangle: red, green, blue, pixels */
    if (in != NULL && argc != 3) {
        paint(in, 480, 320);
    }
    if (in == NULL || (p = read_ppm(in)).rgb == NULL) {
        fprintf(stderr, "%s: no binary PPM picture\n", argc == 3 ? argv[1] : "temporary file");
        return 1;
    }
    choose_points(&p, points);
    status = pbw_triangulate(2, points, NULL, POINTS, NULL, &mesh);
    sums = (long (*)[4])calloc(mesh.simplex_count + 1, sizeof *sums);
    triangle_of = (pbw_index *)malloc((size_t)p.width * (size_t)p.height * sizeof *triangle_of);
    if (status != PBW_OK || sums == NULL || triangle_of == NULL) {
        printf("%s\n", pbw_status_string(status == PBW_OK ? PBW_ERROR_MEMORY : status));
        return 1;
    }
    for (size_t i = 0; i < mesh.simplex_count; i++) {                  /* slivers between pixels: a corner's colour */
        const double *q = points + 2 * mesh.simplices[3 * i];
        for (int k = 0; k < 4; k++) {
            sums[i][k] = k < 3 ? p.rgb[3 * ((int)q[1] * p.width + (int)q[0]) + k] : 1;
        }
    }
    for (int i = 0; i < p.width * p.height; i++) {
        const double q[2] = { i % p.width + 0.5, i / p.width + 0.5 };
        for (size_t k = 0; k < 3;) {   /* walk to the triangle: across an edge with the pixel on its far side */
            const pbw_index *c = mesh.simplices + 3 * (size_t)t;
            int far = pbw_orient2(points + 2 * c[(k + 1) % 3], points + 2 * c[(k + 2) % 3], q) < 0;
            t = far ? mesh.neighbors[3 * (size_t)t + k] : t;           /* never outside: the corners are points */
            k = far ? 0 : k + 1;
        }
        triangle_of[i] = t;
        for (int k = 0; k < 4; k++) {
            sums[t][k] += k < 3 ? p.rgb[3 * i + k] : 1;
        }
    }
    for (int i = 0; i < 3 * p.width * p.height; i++) {
        const long *s = sums[triangle_of[i / 3]];
        off += labs(p.rgb[i] - s[i % 3] / s[3]);
    }
    printf("%d by %d pixels, %zu triangles, off by %.2f of 255 a pixel and channel\n", p.width, p.height,
           mesh.simplex_count, (double)off / (3.0 * p.width * p.height));
    fclose(in);
    if (argc == 3 && !write_svg(argv[2], &p, &mesh, sums)) {
        perror(argv[2]);
        return 1;
    }
    free(p.rgb);
    free(sums);
    free(triangle_of);
    pbw_free(&mesh);
    return 0;
}
