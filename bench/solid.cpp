// solid.cpp: pbw_mesh3.h and pbw_improve.h beside CGAL Mesh_3, Gmsh and TetGen: tetrahedra, dihedral angles, seconds
// of processor time, goals.
//     solid                    a knot and turned parts of tests/parts.h, each with one length of edges
//     solid MODEL.off H...     a smooth closed surface of triangles in OFF; for each length of edges H
// CGAL: features of 40 degrees, facet angle 25, facet distance 0.1 H, facet and cell size H, then perturb and exude,
// its defaults.  TetGen: -pq1.4/15 with the volume of a regular tetrahedron of edge H; it keeps the input's facets.
// Gmsh, the program: surfaces classified by 40 degrees and meshed anew with size H, its default algorithm with
// -optimize, and HXT; its seconds have reading and writing in them.
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
#include "../tests/parts.h"
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_polyhedron_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/exude_mesh_3.h>
#include <CGAL/make_mesh_3.h>
#include <CGAL/perturb_mesh_3.h>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#define TETLIBRARY
#include <tetgen.h>
#include <unistd.h>
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

// The goals of a model: dihedral angles, for smooth surfaces or sharp ones.
struct Goal { double least, permille, largest; };
static const Goal smooth = { 28, 29.5, 152 }, sharp = { 24, 28, 155 };

static void print(const char *name, double seconds, const pbw_tets &mesh)
{
    pbw_quality q;
    pbw_tets_quality(&mesh, nullptr, &q);
    std::printf("  %-10s %8zu tetrahedra  %6.2f / %6.2f / %6.2f degrees, %6zu below 20  %8.3f s  %8.0f per second\n",
                name, mesh.tet_count, q.least, q.permille, q.largest, q.below[2], seconds,
                (double)mesh.tet_count / seconds);
}

static void print(const char *name, double seconds, const double *points, const pbw_index *corners, std::size_t count)
{
    pbw_tets mesh = {};
    mesh.points = points;
    mesh.corners = corners;
    mesh.tet_count = count;
    print(name, seconds, mesh);
}

static void judge(const char *what, double measured, const char *relation, double goal, bool met)
{
    std::printf("    %-44s %10.4g  goal %s %g: %s\n", what, measured, relation, goal, met ? "met" : "MISSED");
}

static void at_least(const char *what, double measured, double goal)
{
    judge(what, measured, ">=", goal, measured >= goal);
}

static void at_most(const char *what, double measured, double goal)
{
    judge(what, measured, "<=", goal, measured <= goal);
}

// Restricted Delaunay tetrahedra as they come, improved to 25 and to 30 degrees, one thread.
static void run_improver(const pbw_solid_input &in, double h, pbw_options &options)
{
    pbw_solid_options how = {};
    pbw_tets raw, better;
    how.size = h;
    how.improve.target = -1;
    if (pbw_solid(&in, &how, &options, &raw, nullptr, nullptr) != PBW_OK) {
        std::puts("pbw: failed");
        return;
    }
    for (const double target : { 25.0, 30.0 }) {
        pbw_improve_options improve = {};
        improve.target = target;
        const double start = now();
        if (pbw_improve(&raw, &improve, &options, &better, nullptr) == PBW_OK) {
            const double rate = (double)raw.tet_count / (now() - start);
            at_least(target == 25 ? "raw to 25 degrees, tetrahedra/s" : "raw to 30 degrees, tetrahedra/s", rate,
                     target == 25 ? 500000 : 130000);
            pbw_tets_free(&better);
        }
    }
    pbw_tets_free(&raw);
}

static void run_pbw(const pbwio_cloud &c, double h, const Goal &goal)
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
    const double seconds = now() - start;
    const pbw_quality &q = report.improve.after;
    print("pbw", seconds, mesh);
    at_least("least angle", q.least, goal.least);
    at_least("0.1 % of the tetrahedra's least angles", q.permille, goal.permille);
    at_most("largest angle", q.largest, goal.largest);
    at_least("surface to tetrahedra, a second", (double)mesh.tet_count / seconds, 60000);
    at_most("Hausdorff distance / h", report.distance, 0.15);
    at_most("edges that are no manifold's", (double)report.bad_edges, 0);
    judge("Euler number", (double)report.euler, "==", (double)report.input_euler, report.euler == report.input_euler);
    pbw_tets_free(&mesh);
    run_improver(in, h, options);
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
    // From its 12 points by default CGAL returns no tetrahedra of the knot.
    Complex made = CGAL::make_mesh_3<Complex>(domain, criteria, no_perturb(), no_exude(),
                                              mesh_3_options(number_of_initial_points = 100));
    const double refined = now();
    CGAL::perturb_mesh_3(made, domain);
    CGAL::exude_mesh_3(made);
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
    print("CGAL", seconds, points.data(), corners.data(), corners.size() / 4);
    std::printf("    perturb and exude alone: %.0f tetrahedra/s\n",
                (double)corners.size() / 4 / (start + seconds - refined));
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
    const std::vector<pbw_index> corners(out.tetrahedronlist, out.tetrahedronlist + 4 * out.numberoftetrahedra);
    print("TetGen", seconds, out.pointlist, corners.data(), corners.size() / 4);
}

// Seconds of processor time of children that have ended.
static double children()
{
    rusage used;
    getrusage(RUSAGE_CHILDREN, &used);
    return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec)
         + 1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

static void write_off(const std::string &path, const pbwio_cloud &c)
{
    std::ofstream file(path);
    file.precision(17);
    file << "OFF\n" << c.count << " " << c.triangle_count << " 0\n";
    for (std::size_t i = 0; i < c.count; i++) {
        file << c.points[3 * i] << " " << c.points[3 * i + 1] << " " << c.points[3 * i + 2] << "\n";
    }
    for (std::size_t i = 0; i < c.triangle_count; i++) {
        file << "3 " << c.triangles[3 * i] << " " << c.triangles[3 * i + 1] << " " << c.triangles[3 * i + 2] << "\n";
    }
}

static void write_stl(const std::string &path, const pbwio_cloud &c)
{
    std::ofstream file(path);
    file.precision(17);
    file << "solid part\n";
    for (std::size_t i = 0; i < 3 * c.triangle_count; i++) {
        const double *x = c.points + 3 * (std::size_t)c.triangles[i];
        file << (i % 3 == 0 ? "facet normal 0 0 0\nouter loop\n" : "") << "vertex " << x[0] << " " << x[1] << " "
             << x[2] << "\n" << (i % 3 == 2 ? "endloop\nendfacet\n" : "");
    }
    file << "endsolid part\n";
}

static void run_gmsh(const pbwio_cloud &c, double h, bool hxt)
{
    const std::string base = "build/solid_gmsh", name = hxt ? "Gmsh HXT" : "Gmsh";
    pbwio_cloud made;
    std::remove((base + ".msh").c_str());
    write_stl(base + ".stl", c);
    std::ofstream(base + ".geo") << "Merge \"solid_gmsh.stl\";\nClassifySurfaces{40*Pi/180, 1, 1, Pi};\n"
        "CreateGeometry;\nSurface Loop(1) = Surface{:};\nVolume(1) = {1};\nMesh.MeshSizeMin = " << h
        << ";\nMesh.MeshSizeMax = " << h << ";\nMesh.Algorithm3D = " << (hxt ? 10 : 1) << ";\n";
    const double start = children();
    const std::string run = "timeout 300 gmsh " + base + ".geo -3 -optimize -nt 1 -v 1 -o " + base + ".msh >"
                          + base + ".log 2>&1";
    if (std::system(run.c_str()) != 0 || pbwio_read((base + ".msh").c_str(), nullptr, &made, nullptr) != PBWIO_OK) {
        std::printf("  %-10s no mesh\n", name.c_str());
        return;
    }
    print(name.c_str(), children() - start, made.points, made.tetrahedra, made.tetrahedron_count);
    pbwio_free(&made);
}

// A tube around a trefoil knot, 300 by 40 corners.
static void make_knot(std::vector<double> &x, std::vector<pbw_index> &t)
{
    const unsigned along = 300, around = 40;
    const double turn = 6.283185307179586;
    for (unsigned i = 0; i < along * around; i++) {
        const double a = turn * (i / around) / along, b = turn * (i % around) / around, s = 2 + std::cos(3 * a);
        const double c[3] = { s * std::cos(2 * a), s * std::sin(2 * a), std::sin(3 * a) };
        const double d[3] = { -3 * std::sin(3 * a) * std::cos(2 * a) - 2 * c[1],
                              -3 * std::sin(3 * a) * std::sin(2 * a) + 2 * c[0], 3 * std::cos(3 * a) };
        const double length = std::sqrt(pbwsf__dot(d, d)), out[3] = { std::cos(2 * a), std::sin(2 * a), 0 };
        double u[3], v[3];
        pbwsf__cross(d, out, u);
        const double across = std::sqrt(pbwsf__dot(u, u));
        pbwsf__cross(u, d, v);
        for (int k = 0; k < 3; k++) {
            x.push_back(c[k] + 0.35 * (std::cos(b) * u[k] / across + std::sin(b) * v[k] / (across * length)));
        }
        const pbw_index next = (i / around + 1) % along * around, p = i / around * around, j = i % around;
        const pbw_index m = (j + 1) % around;
        t.insert(t.end(), { p + j, next + m, p + m, p + j, next + j, next + m });
    }
}

// Runs a rival in a process of its own: if it crashes, a line says so.
template <typename Rival> static void apart(const char *name, Rival rival)
{
    int status = 0;
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        rival();
        std::fflush(stdout);
        _exit(0);
    }
    if (child < 0 || waitpid(child, &status, 0) != child || status != 0) {
        std::printf("  %-10s no mesh: it crashed\n", name);
    }
}

static void run(const char *name, const pbwio_cloud &c, double h, const Goal &goal)
{
    const char *path = "build/solid.off";
    std::printf("%s, edges of %g\n", name, h);
    write_off(path, c);
    run_pbw(c, h, goal);
    apart("CGAL", [&] { run_cgal(path, h); });
    run_gmsh(c, h, false);
    run_gmsh(c, h, true);
    apart("TetGen", [&] { run_tetgen(c, h); });
}

static void run_all()
{
    static part made;
    std::vector<double> x;
    std::vector<pbw_index> t;
    pbwio_cloud c = {};
    make_knot(x, t);
    c.points = x.data();
    c.count = x.size() / 3;
    c.triangles = t.data();
    c.triangle_count = t.size() / 3;
    run("knot", c, 0.09, smooth);
    for (std::size_t i = 0; i < PART_COUNT; i++) {
        const std::string name = parts[i].name;
        if (name == "hole" || name == "gear" || name == "fan" || name == "shaft") {
            part_make(i, 1, &made);
            c.points = made.x[0];
            c.count = made.points;
            c.triangles = made.t[0];
            c.triangle_count = made.triangles;
            run(name.c_str(), c, 0.7 * parts[i].size, sharp);
        }
    }
}

int main(int argc, char **argv)
{
    pbwio_cloud cloud;
    pbwio_error error;
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    if (argc < 2) {
        run_all();
        return 0;
    }
    if (argc < 3 || pbwio_read(argv[1], nullptr, &cloud, &error) != PBWIO_OK) {
        std::fprintf(stderr, "%s\n", argc < 3 ? "usage: solid [MODEL.off H...]" : error.text);
        return 2;
    }
    for (int i = 2; i < argc; i++) {
        run(argv[1], cloud, std::atof(argv[i]), smooth);
    }
    pbwio_free(&cloud);
    return 0;
}
