/* query.cpp: pbw_query.h beside CGAL and nanoflann: one thread, in one run, on the same points and queries

   make bench-query [POINTS=n]     uniform points and queries, then a lattice and clusters, processor time; each row
                                   is the median of five runs, ours and the rival's in turn.  speed: how many times
                                   faster ours is; times uniform: how many times longer ours takes than there;
                                   goal: of a number that is demanded, whether it is reached.

   CGAL gets its points as one range, and locates each query of a batch from the last answer, after its own spatial
   sort, which is timed as ours is; so does nanoflann get the queries sorted in the one row, and as they come in the
   other.  Its leaves have 10 points, as it recommends. */
#define PBW_IMPLEMENTATION
#define PBW_QUERY_IMPLEMENTATION
#include "pbw_query.h"
#include "../tests/inputs.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/natural_neighbor_coordinates_2.h>
#include <CGAL/natural_neighbor_coordinates_3.h>
#include <CGAL/spatial_sort.h>
#include <nanoflann.hpp>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace {

typedef CGAL::Exact_predicates_inexact_constructions_kernel kernel;
typedef CGAL::Delaunay_triangulation_2<kernel> delaunay2;
typedef CGAL::Delaunay_triangulation_3<kernel> delaunay3;

struct cloud {                             /* for nanoflann */
    const double *points;
    std::size_t count, dim;
    std::size_t kdtree_get_point_count() const { return count; }
    double kdtree_get_pt(std::size_t i, std::size_t k) const { return points[i * dim + k]; }
    template <class box> bool kdtree_get_bbox(box &) const { return false; }
};

void natural(const delaunay2 &mesh, const delaunay2::Point &p)
{
    std::vector<std::pair<delaunay2::Point, double>> weights;
    CGAL::natural_neighbor_coordinates_2(mesh, p, std::back_inserter(weights));
}

void natural(const delaunay3 &mesh, const delaunay3::Point &p)
{
    std::vector<std::pair<delaunay3::Vertex_handle, double>> weights;
    double norm;
    CGAL::sibson_natural_neighbor_coordinates_3(mesh, p, std::back_inserter(weights), norm);
}

double seconds(const std::function<void()> &work)
{
    std::timespec from, to;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
    work();
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
    return double(to.tv_sec - from.tv_sec) + 1e-9 * double(to.tv_nsec - from.tv_nsec);
}

std::size_t volatile sink;
int kind;                                  /* of points */
std::map<std::string, double> uniform;     /* time of each row on uniform points */

double build;                              /* us a point */

/* What is demanded: to be some times as fast as the rival, or so many queries a microsecond, or a share of the
   build's time of a point; other kinds of points take at most twice as long as uniform ones.  0 = nothing. */
struct demand { double speed, rate, share; };

void goal(const char *what, double value, double bound, bool most)
{
    if (bound > 0) {
        std::printf("    goal: %s %.2f, %s %.2f: %s\n", what, value, most ? "at most" : "at least", bound,
                    (most ? value <= bound : value >= bound) ? "REACHED" : "MISSED");
    }
}

void row(const char *name, std::size_t count, const demand &wanted, const std::function<void()> &ours,
         const char *rival, const std::function<void()> &theirs, double part = 1)
{
    std::vector<double> a, b;
    for (int i = 0; i < 5; i++) {
        a.push_back(seconds(ours));
        b.push_back(seconds(theirs) / part);
    }
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    if (kind == INPUT_UNIFORM) {
        uniform[name] = a[2];
    }
    std::printf("%-38s %8.3f us   %-12s %8.3f us   speed %6.2f   times uniform %.2f\n", name,
                a[2] / double(count) * 1e6, rival, b[2] / double(count) * 1e6, b[2] / a[2], a[2] / uniform[name]);
    if (kind == INPUT_UNIFORM) {
        goal("speed", b[2] / a[2], wanted.speed, false);
        goal("M/s", double(count) / a[2] / 1e6, wanted.rate, false);
        goal("of the build", a[2] / double(count) * 1e6 / build, wanted.share, true);
    } else {
        goal("times uniform", a[2] / uniform[name], 2, true);
    }
    std::fflush(stdout);
}

template <int dim, class triangulation> struct locating {
    typedef typename triangulation::Point point;
    static std::vector<point> points(const std::vector<double> &x)
    {
        std::vector<point> made;
        for (std::size_t i = 0; i < x.size(); i += dim) {
            made.push_back(make(&x[i], std::integral_constant<int, dim>()));
        }
        return made;
    }
    static point make(const double *p, std::integral_constant<int, 2>) { return point(p[0], p[1]); }
    template <class three> static point make(const double *p, three) { return point(p[0], p[1], p[2]); }
};

void nearest_rows(int dim, const pbw_mesh &mesh, const pbw_lists &stars, const std::vector<double> &queries,
                  const char *how)
{
    const std::size_t count = queries.size() / std::size_t(dim);
    const cloud all = { mesh.points, mesh.point_count, std::size_t(dim) };
    typedef nanoflann::L2_Simple_Adaptor<double, cloud> metric;
    nanoflann::KDTreeSingleIndexAdaptor<metric, cloud> tree(dim, all, nanoflann::KDTreeSingleIndexAdaptorParams(10));
    std::vector<pbw_index> found(32 * count);
    std::vector<double> distances(32 * count);
    pbw_options options = {};
    options.threads = 1;
    tree.buildIndex();
    for (const std::size_t k : { 1, 8, 32 }) {
        char name[80];
        std::snprintf(name, sizeof name, "%dD %d nearest, %s", dim, int(k), how);
        row(name, count, { k == 1 ? 1.5 : 1, 0, 0 }, [&] {
            pbw_nearest(&mesh, &stars, queries.data(), count, k, &options, found.data(), distances.data());
        }, "nanoflann", [&] {
            std::vector<std::size_t> index(k);
            std::vector<double> square(k);
            for (std::size_t i = 0; i < count; i++) {
                nanoflann::KNNResultSet<double> result(k);
                result.init(index.data(), square.data());
                tree.findNeighbors(result, &queries[i * std::size_t(dim)], nanoflann::SearchParams());
                sink = sink + index[0];
            }
        });
    }
}

/* Queries in clusters, too; on a lattice at its points and in the middle of its edges, faces and cells. */
void fill(int dim, std::size_t n, std::vector<double> &points, std::vector<double> &queries)
{
    const std::size_t size = std::size_t(dim);
    if (kind != INPUT_CLUSTERS) {
        input_fill(kind, dim, n, 1, points.data());
        input_fill(kind, dim, n, 2, queries.data());
        for (std::size_t i = 0; kind == INPUT_LATTICE && i < n * size; i++) {
            queries[i] += i * 2654435761u >> 7 & 1 ? 0.5 : 0;
        }
        return;
    }
    std::vector<double> both(2 * n * size);
    input_fill(kind, dim, 2 * n, 1, both.data());
    for (std::size_t i = 0; i < n * size; i++) {
        points[i] = both[i / size * 2 * size + i % size];
        queries[i] = both[i / size * 2 * size + size + i % size];
    }
}

template <int dim, class triangulation> void run(std::size_t n, unsigned flags, const char *numbering)
{
    typedef locating<dim, triangulation> with;
    std::vector<double> points(n * dim), queries(n * dim);
    pbw_options options = {};
    pbw_mesh mesh;
    pbw_lists stars, lists;
    std::vector<pbw_index> found(n), order(n);
    char name[80];
    fill(dim, n, points, queries);
    options.threads = 1;
    options.flags = flags;
    build = seconds([&] { pbw_triangulate(dim, points.data(), nullptr, n, &options, &mesh); }) / double(n) * 1e6;
    options.flags = 0;
    const double star = seconds([&] { pbw_stars(&mesh, &options, &stars); });
    std::printf("%dD, %zu points, %s, %s: build %.3f us, stars %.3f us a point\n", dim, n, input_name(kind),
                numbering, build, star / double(n) * 1e6);

    const auto other = with::points(points);
    const triangulation theirs(other.begin(), other.end());
    std::snprintf(name, sizeof name, "%dD locate, batch", dim);
    row(name, n, { 2, 0, dim == 3 ? 0.6 : 0 }, [&] {
        pbw_locate(&mesh, queries.data(), n, &options, found.data(), nullptr);
    }, "CGAL", [&] {
        auto sorted = with::points(queries);
        CGAL::spatial_sort(sorted.begin(), sorted.end());
        auto at = theirs.locate(sorted[0]);
        for (const auto &p : sorted) {
            at = theirs.locate(p, at);
        }
    });
    pbw_finder *finder;
    pbw_finder_create(&mesh, &options, &finder);
    const std::size_t some = n / 20;
    std::snprintf(name, sizeof name, "%dD locate, single, finder", dim);
    row(name, some, { 0, dim == 3 ? 0.4 : 0, 0 }, [&] {
        for (std::size_t i = 0; i < some; i++) {
            sink = sink + pbw_finder_locate(finder, &queries[i * dim], nullptr);
        }
    }, "CGAL", [&] {
        const auto asked = with::points(std::vector<double>(queries.begin(), queries.begin() + long(some * dim)));
        for (const auto &p : asked) {
            sink = sink + std::size_t(theirs.is_infinite(theirs.locate(p)));
        }
    });
    pbw_finder_free(finder);
    nearest_rows(dim, mesh, stars, queries, "as they come");
    pbw_order(dim, queries.data(), n, &options, order.data());
    std::vector<double> sorted;
    for (pbw_index i : order) {
        sorted.insert(sorted.end(), &queries[i * dim], &queries[i * dim] + dim);
    }
    nearest_rows(dim, mesh, stars, sorted, "sorted");
    const std::size_t few = n / 10;
    const auto asked = with::points(std::vector<double>(sorted.begin(), sorted.begin() + long(few * dim)));
    std::snprintf(name, sizeof name, "%dD Sibson", dim);
    row(name, few, { 0, dim == 3 ? 0.15 : 1, 0 }, [&] {
        pbw_coordinates(&mesh, sorted.data(), few, PBW_SIBSON, &options, &lists);
        pbw_lists_free(&lists);
    }, "CGAL", [&] {
        for (std::size_t i = 0; i < asked.size() / 10; i++) {        /* the first tenth: it takes long */
            natural(theirs, asked[i]);
        }
    }, 0.1);
    pbw_lists_free(&stars);
    pbw_free(&mesh);
}

} // namespace

int main(int argc, char **argv)
{
    const std::size_t n = argc > 1 ? std::size_t(std::atof(argv[1])) : 100000;
    const int kinds[3] = { INPUT_UNIFORM, INPUT_LATTICE, INPUT_CLUSTERS };
    for (const unsigned flags : { 0u, unsigned(PBW_CURVE_ORDER) }) {
        for (const int some : kinds) {
            kind = some;
            run<3, delaunay3>(n, flags, flags == 0 ? "numbered at random" : "numbered along the curve");
            run<2, delaunay2>(n, flags, flags == 0 ? "numbered at random" : "numbered along the curve");
        }
    }
    return 0;
}
