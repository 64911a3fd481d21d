/* hashes_lib.c: prints a hash of what each companion header makes: samples, cells, a refined plane domain, a solid,
   an adapted one and a field on it.  tests/hashes.sh compares what differently compiled programs print. */
#define PBW_SAMPLE_IMPLEMENTATION
#include "pbw_sample.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#define PBW_MESH2_IMPLEMENTATION
#include "pbw_mesh2.h"
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_MESH3_IMPLEMENTATION
#include "pbw_mesh3.h"
#define PBW_ADAPT3_IMPLEMENTATION
#include "pbw_adapt3.h"
#include "parts.h"
#include "zoo.h"

static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t count)   /* FNV-1a */
{
    const unsigned char *at = (const unsigned char *)bytes;
    size_t i;
    for (i = 0; i < count && at != NULL; i++) {
        hash = (hash ^ at[i]) * 0x100000001b3u;
    }
    return hash;
}

static void print_one(const char *name, int status, const double *x, size_t reals, const pbw_index *ids, size_t count)
{
    const uint64_t hash = hash_bytes(0xcbf29ce484222325u, x, reals * sizeof *x);
    printf("%s: %d %lu %lu %016llx\n", name, status, (unsigned long)reals, (unsigned long)count,
           (unsigned long long)hash_bytes(hash, ids, count * sizeof *ids));
}

static void print_samples(const part *m)
{
    pbwsample_model model;
    pbwsample_options how;
    pbwsample_set set;
    pbw_status status;
    memset(&model, 0, sizeof model);
    memset(&how, 0, sizeof how);
    memset(&set, 0, sizeof set);
    model.point_count = m->points;
    model.triangle_count = m->triangles;
    model.points = m->x[0];
    model.triangles = m->t[0];
    how.radius = 0.08;
    status = pbwsample_poisson(&model, &how, &set);
    status = status != PBW_OK ? status : pbwsample_volume(&model, &how, &set);
    print_one("samples", (int)status, set.points, 3 * set.count, set.triangles, set.count);
    pbwsample_free(&set);
}

static void print_cells(int dim, const double *points, size_t count)
{
    pbw_mesh mesh;
    pbw_cells cells;
    pbw_domain domain;
    pbw_status status;
    const double box[6] = { 0.1, 0.1, dim == 3 ? 0.1 : 0.9, 0.9, 0.9, 0.9 };
    memset(&domain, 0, sizeof domain);
    memset(&cells, 0, sizeof cells);
    domain.box = box;
    status = pbw_triangulate(dim, points, NULL, count, NULL, &mesh);
    status = status != PBW_OK ? status
           : pbw_cells_of(&mesh, &domain, PBW_CELLS_FACETS | PBW_CELLS_SHAPES, NULL, &cells);
    print_one("volumes", (int)status, cells.volumes, cells.cell_count, cells.neighbors, cells.facet_count);
    print_one("centroids", dim, cells.centroids, (size_t)dim * cells.cell_count, NULL, 0);
    print_one("areas", dim, cells.areas, cells.facet_count, NULL, 0);
    print_one("vertices", dim, cells.vertices, (size_t)dim * cells.vertex_count, NULL, 0);
    pbw_cells_free(&cells);
    pbw_free(&mesh);
}

static void print_plane(const double *points, size_t count)
{
    pbw_plane_input in;
    pbw_plane_options how;
    pbw_plane plane;
    pbw_status status;
    memset(&in, 0, sizeof in);
    memset(&how, 0, sizeof how);
    in.points = points;
    in.point_count = count;
    how.flags = PBW_PLANE_REFINE;
    how.angle = 31;
    how.area = 1e-3;
    status = pbw_plane_make(&in, &how, &plane);
    print_one("plane", (int)status, plane.points, 2 * plane.point_count, plane.triangles, 3 * plane.triangle_count);
    pbw_plane_free(&plane);
}

static void print_solid(const part *m)
{
    pbw_solid_input in;
    pbw_solid_options how;
    pbw_tets mesh, better;
    pbw_improve_options to_sizes;
    pbw_status status;
    double *sizes, *error, *values;
    size_t i;
    memset(&in, 0, sizeof in);
    memset(&how, 0, sizeof how);
    memset(&better, 0, sizeof better);
    memset(&to_sizes, 0, sizeof to_sizes);
    in.points = m->x[0];
    in.point_count = m->points;
    in.triangles = m->t[0];
    in.triangle_count = m->triangles;
    how.size = 0.14;
    status = pbw_solid(&in, &how, NULL, &mesh, NULL, NULL);
    print_one("solid", (int)status, mesh.points, 3 * mesh.point_count, mesh.corners, 4 * mesh.tet_count);
    sizes = (double *)zoo_grow(NULL, (mesh.point_count + 1) * sizeof *sizes);
    error = (double *)zoo_grow(NULL, (mesh.tet_count + 1) * sizeof *error);
    for (i = 0; i < mesh.tet_count; i++) {
        error[i] = fabs(mesh.points[3 * (size_t)mesh.corners[4 * i]]);
    }
    pbw_tets_sizes(&mesh, error, mesh.tet_count, sizes);
    print_one("sizes", 0, sizes, mesh.point_count, NULL, 0);
    to_sizes.sizes = sizes;
    status = status != PBW_OK ? status : pbw_improve(&mesh, &to_sizes, NULL, &better, NULL);
    print_one("adapted", (int)status, better.points, 3 * better.point_count, better.corners, 4 * better.tet_count);
    values = (double *)zoo_grow(NULL, (better.point_count + 1) * sizeof *values);
    status = status != PBW_OK ? status : pbw_tets_transfer(&mesh, &better, sizes, 1, NULL, values);
    print_one("values", (int)status, values, status == PBW_OK ? better.point_count : 0, NULL, 0);
    free(values);
    free(error);
    free(sizes);
    pbw_tets_free(&better);
    pbw_tets_free(&mesh);
}

int main(void)
{
    enum { COUNT = 1200 };
    static double points[3 * COUNT];
    static part shaft;
    uint64_t state = 1;
    size_t i;
    for (i = 0; i < 3 * COUNT; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = (double)(state >> 11) / 9007199254740992.0;
    }
    (void)part_make(2, 1, &shaft);
    print_samples(&shaft);
    print_cells(2, points, COUNT);
    print_cells(3, points, COUNT);
    print_plane(points, COUNT / 4);
    print_solid(&shaft);
    return 0;
}
