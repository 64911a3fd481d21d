/* coast.c: a sea with a rough coast and islands, meshed fine at the shores and coarse in the open, as for tides.
   cc -O2 -I. -Iexamples/lib examples/coast.c -o coast -lpthread -lm && ./coast [sea.svg]
   Prints expected/coast.txt; the exit status is 1 if an angle is below 33 degrees or water is lost. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#include "draw.h"

enum { SHORE = 900, ISLANDS = 16, ISLE = 180, MOST = SHORE + ISLANDS * ISLE };

static double points[2 * MOST];
static size_t first[ISLANDS + 2];
static unsigned long long state = 7;

static double random_unit(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) / 9007199254740992.0;
}

/* A ring of n points about x, y: waves of eight lengths, the shorter the lower.  It does not cross itself, as each
   direction has one distance, within 1 - 2.5 rough and 1 + 2.5 rough radii. */
static void add_ring(size_t ring, size_t n, const double place[3], double rough)
{
    double phase[8];
    for (int k = 0; k < 8; k++) {
        phase[k] = 6.283185307179586 * random_unit();
    }
    first[ring + 1] = first[ring] + n;
    for (size_t i = 0; i < n; i++) {
        const double turn = 6.283185307179586 * (double)i / (double)n;
        double r = 1, height = rough, *at = points + 2 * (first[ring] + i);
        for (int k = 0; k < 8; k++, height *= 0.6) {
            r += height * sin((1 << k) * turn + phase[k]);
        }
        at[0] = place[0] + 1.5 * place[2] * r * cos(turn);
        at[1] = place[1] + place[2] * r * sin(turn);
    }
}

/* Islands that keep away from each other and from the coast. */
static void add_islands(void)
{
    double place[ISLANDS][3];
    for (int i = 0; i < ISLANDS; ) {
        double *p = place[i];
        p[2] = 0.3 + 1.2 * random_unit() * random_unit();
        p[0] = 18 * (random_unit() - 0.5);
        p[1] = 12 * (random_unit() - 0.5);
        int free = hypot(p[0] / 1.5, p[1]) + 1.5 * p[2] < 6.5;
        for (int j = 0; j < i; j++) {
            free = free && hypot((p[0] - place[j][0]) / 1.5, p[1] - place[j][1]) > 1.6 * (p[2] + place[j][2]);
        }
        if (free) {
            add_ring(1 + (size_t)i++, ISLE, p, 0.22);
        }
    }
}

int main(int argc, char **argv)
{
    const double sea[3] = { 0, 0, 10 }, lines[2] = { 0.35, 1.6 };
    pbw_plane_options options = { 0 };
    pbw_plane_input input = { 0 };
    pbw_plane plane = { 0 };
    pbw_index segments[2 * MOST];
    double least = 180, longest = 0, water = 0, land = 0;
    int failed = 0;
    add_ring(0, SHORE, sea, 0.14);
    add_islands();
    for (size_t ring = 0; ring <= ISLANDS; ring++) {
        for (size_t i = first[ring]; i < first[ring + 1]; i++) {
            const size_t next = i + 1 < first[ring + 1] ? i + 1 : first[ring];
            const double *a = points + 2 * i, *b = points + 2 * next;
            segments[2 * i] = (pbw_index)i;
            segments[2 * i + 1] = (pbw_index)next;
            land += (ring == 0 ? 1 : -1) * (a[0] * b[1] - a[1] * b[0]) / 2;
        }
    }
    input.points = points;
    input.point_count = input.segment_count = MOST;
    input.segments = segments;
    options.rule = PBW_PLANE_EVEN_ODD;
    options.flags = PBW_PLANE_REFINE;
    options.angle = 33;                              /* shores are short lines: angles make triangles small there */
    options.size = 1.5;
    if (pbw_plane_make(&input, &options, &plane) != PBW_OK) {
        puts(plane.what);
        return 1;
    }
    unsigned *fill = (unsigned *)malloc((plane.triangle_count + 1) * sizeof *fill);
    for (size_t i = 0; fill != NULL && i < plane.triangle_count; i++) {
        double most = 0;
        for (size_t k = 0; k < 3; k++) {
            const double *a = plane.points + 2 * plane.triangles[3 * i + k];
            const double *b = plane.points + 2 * plane.triangles[3 * i + (k + 1) % 3];
            const double *c = plane.points + 2 * plane.triangles[3 * i + (k + 2) % 3];
            const double area2 = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            const double dot = (b[0] - a[0]) * (c[0] - a[0]) + (b[1] - a[1]) * (c[1] - a[1]);
            least = fmin(least, atan2(area2, dot) * 57.29577951308232);
            most = fmax(most, hypot(b[0] - a[0], b[1] - a[1]));
            water += area2 / 6;
        }
        longest = fmax(longest, most);
        fill[i] = blend(0xe3f4f4, 0x2a7fa8, log(most / 0.04) / log(25));
    }
    printf("%d islands, %d region, no angle below %.0f degrees, edges up to %.0f\n", ISLANDS, (int)plane.region_count,
           floor(least + 1e-9), ceil(longest));
    failed = fill == NULL || least < 33 - 1e-9 || fabs(water - land) > 1e-9 * land
          || (argc > 1 && draw(argv[1], &plane, fill, lines));
    free(fill);
    pbw_plane_free(&plane);
    return failed;
}
