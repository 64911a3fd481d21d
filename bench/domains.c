/* domains.c: refinement of the domains of tests/domains.h, at 30 and at 33 degrees: triangles, points that refinement
   put there, least angles, triangles with smaller angles than wanted, seconds of processor time.
       domains [NAME...]     domains whose names begin so; default: all
       domains --large N     the coasts in a sea by an area for N million triangles, checked; memory at most
   "at small angles" are triangles with corners on two segments of the input that meet at less than 60 degrees; "else"
   is the least angle of all others. */
#define _XOPEN_SOURCE 600                              /* getrusage */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#include "domains.h"
#include "planes.h"
#include <sys/resource.h>
#include <time.h>

static void refine(const domain *e, drawing *d, double angle)
{
    pbw_plane_options options;
    pbw_options build;
    pbw_plane plane;
    domain_verdict v;
    const clock_t start = clock();
    double seconds;
    memset(&options, 0, sizeof options);
    memset(&build, 0, sizeof build);
    build.threads = 1;
    options.build = &build;
    options.rule = e->rule;
    options.flags = e->flags | PBW_PLANE_REFINE;
    options.angle = angle;
    if (pbw_plane_make(input_of(d), &options, &plane) != PBW_OK) {
        printf("%-17s %7zu %2.0f  %s\n", e->name, d->segment_count, angle, plane.what);
        pbw_plane_free(&plane);
        return;
    }
    seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    v = domain_judge(d, &plane, angle);
    printf("%-17s %7zu %2.0f %8zu %8zu %6.2f %6.2f %7zu %7zu %5zu %7.3f\n", e->name, d->segment_count, angle,
           plane.triangle_count, plane.report.steiner_count, v.least, v.least_free, v.sharp, v.sharp - v.sharp_free,
           plane.report.short_edges, seconds);
    (void)fflush(stdout);
    pbw_plane_free(&plane);
}

/* The mean triangle of a mesh with this bound has 0.63 of its area. */
static int refine_large(double millions)
{
    pbw_plane_options options;
    pbw_options build;
    pbw_plane plane;
    drawing d;
    struct rusage usage;
    const clock_t start = clock();
    const char *fault;
    double seconds;
    memset(&d, 0, sizeof d);
    memset(&options, 0, sizeof options);
    memset(&build, 0, sizeof build);
    build.threads = 1;
    draw_sea(&d, 1);
    options.build = &build;
    options.rule = PBW_PLANE_SEEDS;
    options.flags = PBW_PLANE_REFINE;
    options.area = 121 / 0.63e6 / millions;
    if (pbw_plane_make(input_of(&d), &options, &plane) != PBW_OK) {
        printf("%s\n", plane.what);
        return 1;
    }
    seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    (void)getrusage(RUSAGE_SELF, &usage);
    printf("%zu triangles, %zu points, %zu sharp, %zu large, %.1f s, %.2f M/s, %.2f GB at most, %.0f bytes each\n",
           plane.triangle_count, plane.point_count, plane.report.small_angles, plane.report.too_large, seconds,
           1e-6 * (double)plane.triangle_count / seconds, 1e-6 * (double)usage.ru_maxrss,
           1e3 * (double)usage.ru_maxrss / (double)plane.triangle_count);
    (void)fflush(stdout);
    fault = planes_fault(&plane, NULL, 0, 0);
    printf("%s\n", fault == NULL ? "checked" : fault);
    pbw_plane_free(&plane);
    drawing_free(&d);
    return fault != NULL;
}

static int is_wanted(const char *name, int argc, char **argv)
{
    int i, found = argc < 2;
    for (i = 1; i < argc; i++) {
        found |= strncmp(name, argv[i], strlen(argv[i])) == 0;
    }
    return found;
}

int main(int argc, char **argv)
{
    size_t i;
    if (argc == 3 && strcmp(argv[1], "--large") == 0) {
        return refine_large(atof(argv[2]));
    }
    printf("%-17s %7s %2s %8s %8s %6s %6s %7s %7s %5s %7s\n", "domain", "segment", "", "triangle", "Steiner", "least",
           "else", "sharp", "at small", "short", "s");
    for (i = 0; i < DOMAIN_COUNT; i++) {
        drawing d;
        if (!is_wanted(domains[i].name, argc, argv)) {
            continue;
        }
        memset(&d, 0, sizeof d);
        domains[i].make(&d, 1);
        refine(domains + i, &d, 30);
        refine(domains + i, &d, 33);
        drawing_free(&d);
    }
    return 0;
}
