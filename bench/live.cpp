/* live.cpp: pbw_live beside CGAL's insert, remove and move: one thread, in one run, on the same points

   make bench-live [POINTS=n]      uniform points, processor time; each row is the median of five runs, ours and the
                                   rival's in turn.  B: our own build of all points in the same run, per point.

   2 % of the points are removed, inserted again and moved by a tenth of the mean distance, in random order, for both:
   ours sorts them inside, CGAL sorts those that it inserts as a range. */
#define PBW_IMPLEMENTATION
#define PBW_LIVE_IMPLEMENTATION
#include "pbw_live.h"
#include "../tests/inputs.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <vector>

namespace {

typedef CGAL::Exact_predicates_inexact_constructions_kernel kernel;
typedef CGAL::Delaunay_triangulation_2<kernel> delaunay2;
typedef CGAL::Delaunay_triangulation_3<kernel> delaunay3;

double seconds(const std::function<void()> &work)
{
    std::timespec from, to;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
    work();
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
    return double(to.tv_sec - from.tv_sec) + 1e-9 * double(to.tv_nsec - from.tv_nsec);
}

void good(pbw_status status)
{
    if (status != PBW_OK) {
        std::printf("%s\n", pbw_status_string(status));
        std::exit(1);
    }
}

double median(std::vector<double> times)
{
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

double build_time;                         /* B, seconds a point */

void row(int dim, const char *name, std::size_t count, const std::vector<double> &ours,
         const std::vector<double> &theirs)
{
    const double a = median(ours) / double(count);
    std::printf("%dD %-34s %8.3f us  %6.2f B", dim, name, a * 1e6, a / build_time);
    if (!theirs.empty()) {
        const double b = median(theirs) / double(count);
        std::printf("   CGAL %8.3f us   speed %6.2f", b * 1e6, b / a);
    }
    std::printf("\n");
    std::fflush(stdout);
}

delaunay2::Point point_of(const double *p, const delaunay2 &)
{
    return delaunay2::Point(p[0], p[1]);
}

delaunay3::Point point_of(const double *p, const delaunay3 &)
{
    return delaunay3::Point(p[0], p[1], p[2]);
}

template <class mesh> void remove_insert_move(int dim, const std::vector<double> &points, std::size_t n)
{
    const std::size_t d = std::size_t(dim), m = n / 50;
    const double step = 0.1 * std::pow(1.0 / double(n), 1.0 / dim);
    std::vector<double> ours[6], theirs[6], some(m * d), moved(m * d), all(points);
    std::vector<pbw_index> ids(m), back(m);
    std::vector<typename mesh::Vertex_handle> handles(m);
    std::vector<typename mesh::Point> range;
    uint64_t state = 7;
    pbw_options options = pbw_options();
    pbw_live *live = nullptr;
    pbw_mesh built, view;
    mesh rival;
    options.threads = 1;
    for (int i = 0; i < 5; i++) {
        ours[0].push_back(seconds([&] { good(pbw_triangulate(dim, points.data(), nullptr, n, &options, &built)); }));
        ours[1].push_back(seconds([&] { good(pbw_live_create(&built, &options, &live)); }));
        ours[2].push_back(seconds([&] { good(pbw_live_view(live, &view)); }));
        pbw_free(&view);
        if (i < 4) {
            pbw_live_free(live);
            pbw_free(&built);
        }
    }
    build_time = median(ours[0]) / double(n);
    row(dim, "build (B)", n, ours[0], {});
    row(dim, "live from a mesh", n, ours[1], {});
    row(dim, "view", n, ours[2], {});
    for (std::size_t i = 0; i < n; i++) {
        range.push_back(point_of(&points[i * d], rival));
    }
    rival.insert(range.begin(), range.end());
    for (int run = 0; run < 5; run++) {
        for (std::size_t i = 0; i < m; i++) {
            const std::size_t k = (i * 50 + input_below(&state, 50));
            ids[i] = pbw_index(k);
        }
        range.clear();
        for (std::size_t i = 0; i < m; i++) {
            for (std::size_t k = 0; k < d; k++) {
                some[i * d + k] = all[ids[i] * d + k];
                moved[i * d + k] = some[i * d + k] + step * (2 * input_uniform(&state) - 1);
            }
            range.push_back(point_of(&some[i * d], rival));
            handles[i] = rival.nearest_vertex(range.back());
        }
        ours[3].push_back(seconds([&] {
            good(pbw_live_remove(live, ids.data(), m));
            good(pbw_live_commit(live, nullptr));
        }));
        theirs[3].push_back(seconds([&] { for (auto h : handles) { rival.remove(h); } }));
        ours[4].push_back(seconds([&] {
            good(pbw_live_insert(live, some.data(), nullptr, m, back.data()));
            good(pbw_live_commit(live, nullptr));
        }));
        theirs[4].push_back(seconds([&] { rival.insert(range.begin(), range.end()); }));
        for (std::size_t i = 0; i < m; i++) {
            for (std::size_t k = 0; k < d; k++) {
                all[back[i] * d + k] = some[i * d + k];
                moved[i * d + k] = some[i * d + k] + step * (2 * input_uniform(&state) - 1);
            }
            handles[i] = rival.nearest_vertex(range[i]);
        }
        ours[5].push_back(seconds([&] {
            good(pbw_live_move(live, back.data(), moved.data(), m));
            good(pbw_live_commit(live, nullptr));
        }));
        theirs[5].push_back(seconds([&] {
            for (std::size_t i = 0; i < m; i++) {
                rival.move_if_no_collision(handles[i], point_of(&moved[i * d], rival));
            }
        }));
        for (std::size_t i = 0; i < m * d; i++) {
            all[back[i / d] * d + i % d] = moved[i];
        }
    }
    row(dim, "remove 2 %", m, ours[3], theirs[3]);
    row(dim, "insert 2 %", m, ours[4], theirs[4]);
    row(dim, "move 2 % by 0.1 h", m, ours[5], theirs[5]);
    ours[0].clear();
    for (int run = 0; run < 5; run++) {
        std::vector<double> near(all);
        for (double &x : near) {
            x += 1e-9 * step * input_uniform(&state);
        }
        ours[0].push_back(seconds([&] {
            good(pbw_live_move(live, nullptr, near.data(), n));
            good(pbw_live_commit(live, nullptr));
        }));
    }
    row(dim, "move all by 1e-10 h (verify)", n, ours[0], {});
    for (double part : { 0.01, 0.1 }) {
        ours[0].clear();
        for (int run = 0; run < 5; run++) {
            for (double &x : all) {
                x += part * 10 * step * (2 * input_uniform(&state) - 1);
            }
            ours[0].push_back(seconds([&] {
                good(pbw_live_move(live, nullptr, all.data(), n));
                good(pbw_live_commit(live, nullptr));
            }));
        }
        row(dim, part < 0.05 ? "move all by 0.01 h" : "move all by 0.1 h", n, ours[0], {});
    }
    pbw_live_free(live);
    pbw_free(&built);
}

} // namespace

int main(int argc, char **argv)
{
    const std::size_t n = argc > 1 ? std::size_t(std::atol(argv[1])) : 200000;
    for (int dim = 2; dim <= 3; dim++) {
        std::vector<double> points(n * std::size_t(dim));
        input_fill(INPUT_UNIFORM, dim, n, 1, points.data());
        dim == 2 ? remove_insert_move<delaunay2>(dim, points, n) : remove_insert_move<delaunay3>(dim, points, n);
    }
    return 0;
}
