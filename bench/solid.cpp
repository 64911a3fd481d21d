// solid.cpp: pbw_mesh3.h beside CGAL's Mesh_3 and TetGen: tetrahedra, dihedral angles, seconds of processor time.
//     solid MODEL.off H...     a closed surface of triangles in OFF; for each length of edges H
// CGAL: features of 40 degrees, facet angle 25, facet distance 0.1 H, facet and cell size H, then its defaults
// (perturb and exude).  TetGen: -pq1.4/15 with the volume of a regular tetrahedron of edge H; it keeps the input's facets.
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_SURFACE_IMPLEMENTATION
#include "pbw_surface.h"
#define PBW_IMPROVE_IMPLEMENTATION
#include "pbw_improve.h"
#define PBW_MESH3_IMPLEMENTATION
#include "pbw_mesh3.h"
#define PBW_IO_IMPLEMENTATION
#include "pbw_io.h"
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_polyhedron_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/make_mesh_3.h>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>
#define TETLIBRARY
#include <tetgen.h>
#include <vector>

typedef CGAL::Exact_predicates_inexact_constructions_kernel Kernel;
typedef CGAL::Mesh_polyhedron_3<Kernel>::type Polyhedron;
typedef CGAL::Polyhedral_mesh_domain_with_features_3<Kernel> Domain;
typedef CGAL::Mesh_triangulation_3<Domain>::type Triangulation;
typedef CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index, Domain::Curve_index> Complex;
typedef CGAL::Mesh_criteria_3<Triangulation> Criteria;

static double now()
{
    return (double)std::clock() / CLOCKS_PER_SEC;
}

static void print(const char *name, double h, double seconds, const std::vector<double> &points,
                  const std::vector<pbw_index> &corners)
{
    pbw_tets mesh = {};
    pbw_quality q;
    mesh.points = points.data();
    mesh.corners = corners.data();
    mesh.tet_count = corners.size() / 4;
    pbw_tets_quality(&mesh, nullptr, &q);
    std::printf("%-8s h %.4g: %8zu tetrahedra, %6.2f / %6.2f / %6.2f degrees, %7zu below 20, %8.3f s, "
                "%8.0f per second\n", name, h, mesh.tet_count, q.least, q.permille, q.largest, q.below[2], seconds,
                (double)mesh.tet_count / seconds);
}

static void run_pbw(const pbwio_cloud &c, double h)
{
    pbw_solid_input in = {};
    pbw_solid_options how = {};
    pbw_solid_report report;
    pbw_options options = {};
    pbw_tets mesh;
    options.threads = 1;
    in.points = c.points;
    in.point_count = c.count;
    in.triangles = c.triangles;
    in.triangle_count = c.triangle_count;
    how.size = h;
    const double start = now();
    if (pbw_solid(&in, &how, &options, &mesh, NULL, &report) != PBW_OK) {
        std::puts("pbw: failed");
        return;
    }
    print("pbw", h, now() - start, std::vector<double>(mesh.points, mesh.points + 3 * mesh.point_count),
          std::vector<pbw_index>(mesh.corners, mesh.corners + 4 * mesh.tet_count));
    std::printf("         bad edges %zu, Euler number %ld of %ld, distance %.3f h\n", report.bad_edges, report.euler,
                report.input_euler, report.distance);
    pbw_tets_free(&mesh);
}

static void run_cgal(const char *path, double h)
{
    Polyhedron surface;
    std::ifstream(path) >> surface;
    const double start = now();
    Domain domain(surface);
    domain.detect_features(40);
    using namespace CGAL::parameters;
    const Criteria criteria(edge_size = h, facet_angle = 25, facet_size = h, facet_distance = 0.1 * h,
                            cell_radius_edge_ratio = 2, cell_size = h);
    const Complex made = CGAL::make_mesh_3<Complex>(domain, criteria);
    const double seconds = now() - start;
    std::map<Triangulation::Vertex_handle, pbw_index> number;
    std::vector<double> points;
    std::vector<pbw_index> corners;
    for (auto cell = made.cells_in_complex_begin(); cell != made.cells_in_complex_end(); ++cell) {
        for (int k = 0; k < 4; k++) {
            const auto added = number.insert({ cell->vertex(k), (pbw_index)number.size() });
            if (added.second) {
                const auto p = cell->vertex(k)->point().point();
                points.insert(points.end(), { p.x(), p.y(), p.z() });
            }
            corners.push_back(added.first->second);
        }
    }
    print("CGAL", h, seconds, points, corners);
}

static void run_tetgen(const pbwio_cloud &c, double h)
{
    tetgenio in, out;
    char flags[64];
    in.numberofpoints = (int)c.count;
    in.pointlist = new REAL[3 * c.count];
    std::copy(c.points, c.points + 3 * c.count, in.pointlist);
    in.numberoffacets = (int)c.triangle_count;
    in.facetlist = new tetgenio::facet[c.triangle_count];
    for (std::size_t i = 0; i < c.triangle_count; i++) {
        tetgenio::facet &f = in.facetlist[i];
        tetgenio::init(&f);
        f.numberofpolygons = 1;
        f.polygonlist = new tetgenio::polygon[1];
        f.polygonlist[0].numberofvertices = 3;
        f.polygonlist[0].vertexlist = new int[3];
        std::copy(c.triangles + 3 * i, c.triangles + 3 * i + 3, f.polygonlist[0].vertexlist);
    }
    (void)std::snprintf(flags, sizeof flags, "pq1.4/15a%.9gQ", 0.11785113 * h * h * h);
    const double start = now();
    tetrahedralize(flags, &in, &out);
    const double seconds = now() - start;
    print("TetGen", h, seconds, std::vector<double>(out.pointlist, out.pointlist + 3 * out.numberofpoints),
          std::vector<pbw_index>(out.tetrahedronlist, out.tetrahedronlist + 4 * out.numberoftetrahedra));
}

int main(int argc, char **argv)
{
    pbwio_cloud cloud;
    pbwio_error error;
    if (argc < 3 || pbwio_read(argv[1], nullptr, &cloud, &error) != PBWIO_OK) {
        std::fprintf(stderr, "%s\n", argc < 3 ? "usage: solid MODEL.off H..." : error.text);
        return 2;
    }
    for (int i = 2; i < argc; i++) {
        run_pbw(cloud, std::atof(argv[i]));
        run_tetgen(cloud, std::atof(argv[i]));
        run_cgal(argv[1], std::atof(argv[i]));
    }
    pbwio_free(&cloud);
    return 0;
}
