/* cells.cpp: Voronoi cells per second, after the mesh and with its build, beside voro++ where it is installed.
       make bench-cells                   or: build/bench_cells [POINTS [ROUNDS]]
   Times are the processor's, of one thread, the medians of rounds that alternate between the programs.  "of B" is the
   time of a cell in units of the build's time of a point.  Periodic: points, weights none, to volumes and centroids,
   beside the build and the volumes of an open box.  goal: of a number that is demanded, whether it is reached. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#include "../tests/inputs.h"
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <vector>
#ifdef BENCH_VORO
#include <voro++/voro++.hh>
#endif

static double now()
{
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct samples {
    std::vector<double> all;
    double median()
    {
        std::sort(all.begin(), all.end());
        return all.empty() ? 0 : all[all.size() / 2];
    }
};

#ifdef BENCH_VORO
/* Volumes and centroids of all cells in a box.  Returns the sum of volumes. */
static double voro_sum(const std::vector<double> &points, const double *b)
{
    const int n = static_cast<int>(points.size() / 3);
    const int side = std::max(1, static_cast<int>(std::cbrt(n / 5.0)));
    voro::container box(b[0], b[3], b[1], b[4], b[2], b[5], side, side, side, false, false, false, 8);
    for (int i = 0; i < n; i++) {
        box.put(i, points[3 * static_cast<size_t>(i)], points[3 * static_cast<size_t>(i) + 1],
                points[3 * static_cast<size_t>(i) + 2]);
    }
    voro::c_loop_all loop(box);
    voro::voronoicell cell;
    double sum = 0, x, y, z;
    if (loop.start()) do {
        if (box.compute_cell(cell, loop)) {
            sum += cell.volume();
            cell.centroid(x, y, z);
        }
    } while (loop.inc());
    return sum;
}
#endif

static void line(const char *what, double seconds, double build, double points)
{
    std::printf("  %-34s %8.1f k/s  %6.3f us  %5.2f of B\n", what, points / seconds / 1e3, seconds / points * 1e6,
                seconds / build);
}

static void goal(const char *what, double value, double bound, bool most)
{
    if (bound > 0) {
        std::printf("    goal: %s %.3g, %s %g: %s\n", what, value, most ? "at most" : "at least", bound,
                    (most ? value <= bound : value >= bound) ? "REACHED" : "MISSED");
    }
}

/* What is demanded of uniform points along the curve, in thousand cells a second; of other points at most twice the
   time of those. */
static void goals(int dim, size_t count, double volumes, double shapes, double all, double periodic)
{
    static double uniform[2][2];
    double *twice = uniform[dim - 2];
    const double n = static_cast<double>(count) / 1e3;
    if (twice[0] > 0) {
        goal("volumes, times uniform", volumes / twice[0], 2, true);
        goal("all, times uniform", shapes / twice[1], 2, true);
        return;
    }
    twice[0] = volumes;
    twice[1] = shapes;
    goal("volumes, k/s", n / volumes, dim == 3 ? 1000 : 0, false);
    goal("with shapes, k/s", n / shapes, dim == 3 ? 500 : 0, false);
    goal("with the build, k/s", n / all, dim == 3 ? 400 : 3000, false);
    goal("periodic / open", periodic / all, count < 500000 ? 1.8 : 1.35, true);
}

static void run(int dim, size_t count, int rounds, unsigned order, int kind)
{
    std::vector<double> points(count * static_cast<size_t>(dim));
    double box[6] = { 0, 0, dim == 3 ? 0.0 : 1.0, 1, 1, 1 }, whole = 1;
    const size_t size = static_cast<size_t>(dim);
    samples build, volumes, facets, shapes, periodic, rival;
    double sum = 0, other = 0;
    input_fill(kind, dim, count, 1, points.data());
    for (size_t k = 0; k < size && kind != INPUT_UNIFORM; k++) {         /* the bounds, and one hundredth more */
        box[k] = box[size + k] = points[k];
        for (size_t i = k; i < points.size(); i += size) {
            box[k] = std::min(box[k], points[i]);
            box[size + k] = std::max(box[size + k], points[i]);
        }
        const double margin = 0.01 * (box[size + k] - box[k]);
        box[k] -= margin;
        box[size + k] += margin;
        whole *= box[size + k] - box[k];
    }
    for (int round = 0; round < rounds; round++) {
        pbw_options options = pbw_options();
        pbw_domain domain = pbw_domain();
        pbw_mesh mesh;
        pbw_cells cells;
        double start = now();
        options.threads = 1;
        options.flags = order;
        domain.box = box;
        if (pbw_triangulate(dim, points.data(), NULL, count, &options, &mesh) != PBW_OK) {
            return;
        }
        build.all.push_back(now() - start);
        options.flags = 0;
        const unsigned what[3] = { 0, PBW_CELLS_FACETS, PBW_CELLS_SHAPES };
        for (int k = 0; k < 3; k++) {
            start = now();
            if (pbw_cells_of(&mesh, &domain, what[k], &options, &cells) != PBW_OK) {
                return;
            }
            (k == 0 ? volumes : k == 1 ? facets : shapes).all.push_back(now() - start);
            sum = 0;
            for (size_t i = 0; i < count; i++) {
                sum += cells.volumes[i];
            }
            pbw_cells_free(&cells);
        }
        pbw_free(&mesh);
        if (order != 0) {
            start = now();
            domain.periodic = (1u << dim) - 1;
            if (pbw_cells_periodic(dim, points.data(), NULL, count, &domain, 0, &options, &cells) != PBW_OK) {
                return;
            }
            periodic.all.push_back(now() - start);
            pbw_cells_free(&cells);
        }
#ifdef BENCH_VORO
        if (dim == 3 && order != 0) {
            start = now();
            other = voro_sum(points, box);
            rival.all.push_back(now() - start);
        }
#endif
    }
    const double n = static_cast<double>(count), b = build.median();
    std::printf("%dD, %zu points, %s, %s\n", dim, count, input_name(kind),
                order != 0 ? "curve order" : "random order");
    line("build (B)", b, b, n);
    line("volumes, centroids", volumes.median(), b, n);
    line("volumes, centroids, facets", facets.median(), b, n);
    line("all, with shapes", shapes.median(), b, n);
    line("build, volumes, centroids", b + volumes.median(), b, n);
    if (!periodic.all.empty()) {
        line("periodic", periodic.median(), b, n);
        std::printf("  periodic / open: %.2f\n", periodic.median() / (b + volumes.median()));
    }
    std::printf("  the volumes' sum is off by %.1e\n", sum / whole - 1);
    goal("sum of volumes, off by", std::fabs(sum / whole - 1), 1e-12, true);
    if (order != 0) {
        goals(dim, count, volumes.median(), shapes.median(), b + volumes.median(), periodic.median());
    }
    if (!rival.all.empty()) {
        line("voro++: volumes, centroids", rival.median(), b, n);
        std::printf("  its sum is off by %.1e; its time / that of build, volumes, centroids: %.1f\n",
                    other / whole - 1,
                    rival.median() / (b + volumes.median()));
    }
}

int main(int argc, char **argv)
{
    const size_t count = argc > 1 ? std::strtoul(argv[1], NULL, 10) : 200000;
    const int rounds = argc > 2 ? std::atoi(argv[2]) : 5;
    for (int dim = 2; dim <= 3; dim++) {
        run(dim, count, rounds, PBW_CURVE_ORDER, INPUT_UNIFORM);
        run(dim, count, rounds, 0, INPUT_UNIFORM);
        run(dim, count, rounds, PBW_CURVE_ORDER, INPUT_LATTICE);
        run(dim, count, rounds, PBW_CURVE_ORDER, INPUT_CLUSTERS);
    }
    return 0;
}
