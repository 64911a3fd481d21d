/* corpus.c: pbw_solid over the parts of tests/parts.h, even and turned: dihedral angles, Euler number, volume,
   Hausdorff distance in sizes, warnings, seconds of processor time; then the histogram.
       corpus [NAME...]     parts whose names begin so; default: all */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_MESH3_IMPLEMENTATION
#include "pbw_mesh3.h"
#include "parts.h"
#include <stdio.h>

static void print(const part_entry *e, int turned, double volume, const pbw_tets *mesh, const pbw_solid_report *r)
{
    const pbw_quality *q = &r->improve.after;
    int k;
    printf("%-10s %-6s %7zu %6.2f %6.2f %6.2f %5zu %4ld %-4s %8.1e %6.3f %5zu %5zu %3d%c %6.2f\n", e->name,
           turned ? "turned" : "", mesh->tet_count, q->least, q->permille, q->largest, q->below[2], r->euler,
           r->euler == e->euler ? "" : "BAD", q->volume / volume - 1, r->distance, r->bad_edges + r->bad_points,
           r->missing_edges, r->rounds, r->settled ? ' ' : '!', r->seconds[0] + r->seconds[1] + r->seconds[2]);
    printf("          ");
    for (k = 0; k < 18; k++) {
        printf(" %zu", q->bins[k]);
    }
    printf("\n");
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
    static part m;
    size_t i;
    printf("%-17s %7s %6s %6s %6s %5s %4s %4s %8s %6s %5s %5s %4s %6s\n", "part", "tets", "least", "0.1 %", "most",
           "<20", "X", "", "volume", "dist/h", "bad", "edges", "rnd", "s");
    for (i = 0; i < 2 * PART_COUNT; i++) {
        const part_entry *e = parts + i / 2;
        const int turned = (int)(i % 2);
        pbw_solid_options how;
        pbw_solid_input in;
        pbw_solid_report r;
        pbw_options options;
        pbw_tets mesh;
        double volume;
        pbw_status status;
        if (!is_wanted(e->name, argc, argv)) {
            continue;
        }
        memset(&how, 0, sizeof how);
        memset(&in, 0, sizeof in);
        memset(&options, 0, sizeof options);
        volume = part_make(i / 2, turned, &m);
        in.points = m.x[0];
        in.point_count = m.points;
        in.triangles = m.t[0];
        in.triangle_count = m.triangles;
        how.size = e->size;
        options.threads = 1;
        status = pbw_solid(&in, &how, &options, &mesh, NULL, &r);
        if (status != PBW_OK) {
            printf("%-10s %-6s %s\n", e->name, turned ? "turned" : "", pbw_status_string(status));
            continue;
        }
        print(e, turned, volume, &mesh, &r);
        (void)fflush(stdout);
        pbw_tets_free(&mesh);
    }
    return 0;
}
