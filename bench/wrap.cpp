// wrap.cpp: CGAL's alpha wrap of a soup of triangles, on one thread: bench/wrap.sh runs it beside pbw wrap.
//     wrap MODEL.off ALPHA OFFSET OUTPUT.off       prints seconds of processor time, without reading and writing
#include <CGAL/alpha_wrap_3.h>
#include <CGAL/boost/graph/IO/polygon_mesh_io.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Surface_mesh.h>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

typedef CGAL::Exact_predicates_inexact_constructions_kernel::Point_3 Point;

int main(int argc, char **argv)
{
    std::vector<Point> points;
    std::vector<std::vector<std::size_t>> faces;
    CGAL::Surface_mesh<Point> wrap;
    if (argc < 5 || !CGAL::IO::read_polygon_soup(argv[1], points, faces)) {
        std::fprintf(stderr, "usage: wrap MODEL.off ALPHA OFFSET OUTPUT.off\n");
        return 2;
    }
    const std::clock_t start = std::clock();
    CGAL::alpha_wrap_3(points, faces, std::atof(argv[2]), std::atof(argv[3]), wrap);
    std::printf("%.3f\n", (double)(std::clock() - start) / CLOCKS_PER_SEC);
    return !CGAL::IO::write_polygon_mesh(argv[4], wrap);
}
