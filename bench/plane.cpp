// plane.cpp: constrained triangulation and refinement of pbw_mesh2.h, beside CGAL where it is installed.
//     make bench-plane        best of three, one thread, processor time; the ratio is ours to theirs
// A goal stands beside what it is a goal for: of ratios and times the most, of speeds the least.  "miss" = not met.
//     ARGS=q: a tenth of the size, for a look; the goals are for the full size.
#define PBW_IMPLEMENTATION
#include "../pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "../examples/lib/pbw_mesh2.h"
#define PBW_ADAPT2_IMPLEMENTATION
#include "../examples/lib/pbw_adapt2.h"
#include "../tests/inputs.h"
#include <cmath>
#include <cstdio>
#include <ctime>
#include <vector>
#ifdef BENCH_CGAL
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#endif

struct drawing {
    std::vector<double> points;
    std::vector<pbw_index> segments;
    size_t size() const { return points.size() / 2; }
    void put(double x, double y) { points.push_back(x); points.push_back(y); }
    void line(size_t a, size_t b) { segments.push_back((pbw_index)a); segments.push_back((pbw_index)b); }
    void ring(size_t first)
    {
        for (size_t i = first; i < size(); i++) {
            line(i, i + 1 < size() ? i + 1 : first);
        }
    }
};

static double seconds()
{
    return (double)std::clock() / CLOCKS_PER_SEC;
}

// ---- inputs

// k x k rough rings of 1000 vertices.
static drawing coasts(int k)
{
    drawing d;
    uint64_t state = 1;
    for (int cell = 0; cell < k * k; cell++) {
        const size_t first = d.size();
        double phase[12];
        for (double &x : phase) {
            x = input_uniform(&state);
        }
        for (int i = 0; i < 1000; i++) {
            double c, s, r = 1, w = 0.3;
            for (int o = 0; o < 12; o++, w *= 0.6) {
                input_turn(i * 0.001 * (1 << o) + phase[o], &c, &s);
                r += 0.5 * w * c;
            }
            r *= 0.3 * (1 + 0.004 * (input_uniform(&state) - 0.5));
            input_turn(i * 0.001, &c, &s);
            d.put(cell % k + r * c, cell / k + r * s);
        }
        d.ring(first);
    }
    return d;
}

// Boxes, each in its cell, turned by 0.1.
static drawing navmesh(int k)
{
    drawing d;
    uint64_t state = 2;
    for (int cell = 0; cell < k * k; cell++) {
        const size_t first = d.size();
        const double x = cell % k + 0.3 * input_uniform(&state), y = cell / k + 0.3 * input_uniform(&state);
        const double w = 0.1 + 0.4 * input_uniform(&state), h = 0.1 + 0.4 * input_uniform(&state);
        for (int i = 0; i < 4; i++) {
            const double px = x + (i == 1 || i == 2 ? w : 0), py = y + (i > 1 ? h : 0);
            d.put(0.995 * px - 0.0998 * py, 0.0998 * px + 0.995 * py);
        }
        d.ring(first);
    }
    return d;
}

// n points, and about as many segments: a part of the Delaunay edges of a copy that is 4 times as high.
static drawing sheared(size_t n)
{
    drawing d;
    uint64_t state = 3;
    pbw_mesh mesh;
    for (size_t i = 0; i < n; i++) {
        d.put(input_uniform(&state), 4 * input_uniform(&state));
    }
    if (pbw_triangulate(2, d.points.data(), NULL, n, NULL, &mesh) == PBW_OK) {
        for (size_t i = 0; i < 3 * mesh.simplex_count; i++) {
            const pbw_index other = mesh.neighbors[i];
            if (other != PBW_NONE && other < i / 3 && input_uniform(&state) < 1.0 / 3) {
                d.line(mesh.simplices[i / 3 * 3 + (i + 1) % 3], mesh.simplices[i / 3 * 3 + (i + 2) % 3]);
            }
        }
    }
    pbw_free(&mesh);
    for (size_t i = 0; i < n; i++) {
        d.points[2 * i + 1] /= 4;
    }
    return d;
}

// Near-horizontal segments through n points.
static drawing crossed(size_t n, size_t lines)
{
    drawing d;
    uint64_t state = 4;
    for (size_t i = 0; i < n; i++) {
        d.put(input_uniform(&state), input_uniform(&state));
    }
    for (size_t i = 0; i < lines; i++) {
        d.put(-0.01, ((double)i + 0.2 + 0.6 * input_uniform(&state)) / (double)lines);
        d.put(1.01, ((double)i + 0.2 + 0.6 * input_uniform(&state)) / (double)lines);
        d.line(d.size() - 2, d.size() - 1);
    }
    return d;
}

static drawing square()
{
    drawing d;
    d.put(0, 0);
    d.put(1, 0);
    d.put(1, 1);
    d.put(0, 1);
    d.ring(0);
    return d;
}

static drawing plate()
{
    drawing d;
    d.put(-0.5, -0.5);
    d.put(10.5, -0.5);
    d.put(10.5, 10.5);
    d.put(-0.5, 10.5);
    d.ring(0);
    for (int k = 0; k < 20; k++) {
        const size_t first = d.size();
        for (int i = 0; i < 200; i++) {
            double c, s;
            input_turn(i / 200.0, &c, &s);
            d.put(k % 5 * 2 + 1 + 0.5 * c, k / 5 * 2.4 + 1.2 + 0.5 * s);
        }
        d.ring(first);
    }
    return d;
}

// ---- runs

static pbw_plane_options options_of(unsigned flags, double angle, double area)
{
    static pbw_options build;
    pbw_plane_options o = pbw_plane_options();
    build.threads = 1;
    o.build = &build;
    o.flags = flags;
    o.angle = angle;
    o.area = area;
    return o;
}

static double ours(const drawing &d, const pbw_plane_options &options, int runs, size_t *triangles)
{
    double best = 1e9;
    for (int run = 0; run < runs; run++) {
        pbw_plane_input input = pbw_plane_input();
        pbw_plane plane = pbw_plane();
        input.points = d.points.data();
        input.point_count = d.size();
        input.segments = d.segments.data();
        input.segment_count = d.segments.size() / 2;
        const double start = seconds();
        if (pbw_plane_make(&input, &options, &plane) != PBW_OK) {
            std::printf("%s\n", plane.what);
        }
        const double time = seconds() - start;
        best = time < best ? time : best;
        *triangles = plane.triangle_count;
        pbw_plane_free(&plane);
    }
    return best;
}

#ifdef BENCH_CGAL
static double theirs(const drawing &d, int runs, size_t *triangles)
{
    typedef CGAL::Exact_predicates_inexact_constructions_kernel kernel;
    typedef CGAL::Constrained_Delaunay_triangulation_2<kernel> triangulation;
    double best = 1e9;
    std::vector<kernel::Point_2> points;
    std::vector<std::pair<size_t, size_t>> segments;
    for (size_t i = 0; i < d.size(); i++) {
        points.push_back(kernel::Point_2(d.points[2 * i], d.points[2 * i + 1]));
    }
    for (size_t i = 0; i < d.segments.size(); i += 2) {
        segments.push_back(std::make_pair((size_t)d.segments[i], (size_t)d.segments[i + 1]));
    }
    for (int run = 0; run < runs; run++) {
        triangulation t;
        const double start = seconds();
        t.insert_constraints(points.begin(), points.end(), segments.begin(), segments.end());
        const double time = seconds() - start;
        best = time < best ? time : best;
        *triangles = t.number_of_faces();
    }
    return best;
}
#endif

// Prints a value, its goal, and whether the value misses it.
static void judge(double value, double goal, bool met)
{
    std::printf(" %8.3g (%.3g)%s", value, goal, met ? "" : " miss");
}

// segments_goal: seconds of the segments alone; 0 = no goal.
static void constrain(const char *name, const drawing &d, int runs, double ratio_goal, double segments_goal)
{
    size_t triangles = 0;
    drawing points = d;
    points.segments.clear();
    const double time = ours(d, options_of(0, 0, 0), runs, &triangles);
    const double alone = ours(points, options_of(0, 0, 0), runs, &triangles);
    std::printf("%-18s %9zu %9zu %8.3f", name, d.size(), d.segments.size() / 2, time);
    if (segments_goal > 0) {
        judge(time - alone, segments_goal, time - alone <= segments_goal);
    } else {
        std::printf(" %8.3f", time - alone);
    }
#ifdef BENCH_CGAL
    size_t other = 0;
    const double theirs_time = theirs(d, runs, &other);
    std::printf(" %8.3f", theirs_time);
    judge(time / theirs_time, ratio_goal, time <= ratio_goal * theirs_time);
    std::printf("%s", other == triangles ? "" : "  other triangles");
#else
    (void)ratio_goal;
#endif
    std::printf("\n");
    std::fflush(stdout);
}

// count: triangles of Triangle 1.6 for this domain, 0 = unknown; speed_goal: million triangles a second, 0 = none.
static void refine(const char *name, const drawing &d, double angle, double area, size_t count, double speed_goal)
{
    size_t triangles = 0;
    const double time = ours(d, options_of(PBW_PLANE_REFINE, angle, area), 2, &triangles);
    const double speed = 1e-6 * (double)triangles / time, share = count > 0 ? (double)triangles / (double)count : 0;
    std::printf("%-18s %9.0f %9zu %8.3f", name, angle, triangles, time);
    if (speed_goal > 0) {
        judge(speed, speed_goal, speed >= speed_goal);
    } else {
        std::printf(" %8.3g", speed);
    }
    if (count > 0) {
        judge(share, 1.05, share <= 1.05);
    }
    std::printf("\n");
    std::fflush(stdout);
}

static double turn_of(const double *p, int a, int b, int c)
{
    const double ux = p[2 * b] - p[2 * a], uy = p[2 * b + 1] - p[2 * a + 1];
    return ux * (p[2 * c + 1] - p[2 * a + 1]) - uy * (p[2 * c] - p[2 * a]);
}

// Whether the corner b of a counter-clockwise polygon, between a and c, is convex and holds no other corner.
static bool is_ear(const double *p, const std::vector<int> &next, int a, int b, int c)
{
    if (turn_of(p, a, b, c) <= 0) {
        return false;
    }
    for (int q = next[(size_t)c]; q != a; q = next[(size_t)q]) {
        if (turn_of(p, a, b, q) >= 0 && turn_of(p, b, c, q) >= 0 && turn_of(p, c, a, q) >= 0) {
            return false;
        }
    }
    return true;
}

// The plain ear clipper, in doubles.  Returns the number of triangles.
static size_t clip_ears(const double *p, int n, std::vector<int> *triangles)
{
    std::vector<int> next((size_t)n);
    int a = 0, tries = 0;
    triangles->clear();
    for (int i = 0; i < n; i++) {
        next[(size_t)i] = (i + 1) % n;
    }
    while (n > 2 && tries++ <= n) {
        const int b = next[(size_t)a], c = next[(size_t)b];
        if (is_ear(p, next, a, b, c)) {
            triangles->insert(triangles->end(), { a, b, c });
            next[(size_t)a] = c;
            n--;
            tries = 0;
        }
        a = next[(size_t)a];
    }
    return triangles->size() / 3;
}

// A rough polygon of n corners.
static drawing polygon(size_t n)
{
    const drawing coast = coasts(1);
    drawing d;
    for (size_t i = 0; i < n; i++) {
        const size_t k = i * 1000 / n;
        d.put(coast.points[2 * k], coast.points[2 * k + 1]);
    }
    return d;
}

// Microseconds of one call, the best of nine rounds.
template <class F> static double microseconds(int calls, F call)
{
    double best = 1e9;
    for (int round = 0; round < 9; round++) {
        const double start = seconds();
        for (int i = 0; i < calls; i++) {
            call();
        }
        const double time = 1e6 * (seconds() - start) / calls;
        best = time < best ? time : best;
    }
    return best;
}

// ears_goal: most times an ear clipper's time; us_goal: most microseconds; 0 = none.
static void small(size_t n, int calls, double ears_goal, double us_goal)
{
    const drawing d = polygon(n);
    const size_t first[2] = { 0, n };
    const pbw_plane_options options = options_of(0, 0, 0);
    std::vector<int> ears;
    size_t triangles = 0, clipped = 0;
    const double us = microseconds(calls, [&] {
        pbw_plane plane = pbw_plane();
        if (pbw_plane_rings(d.points.data(), first, 1, &options, &plane) != PBW_OK) {
            std::printf("%s\n", plane.what);
        }
        triangles = plane.triangle_count;
        pbw_plane_free(&plane);
    });
    const double theirs_us = microseconds(calls, [&] { clipped = clip_ears(d.points.data(), (int)n, &ears); });
    std::printf("polygon of %-7zu %9zu", n, triangles);
    if (us_goal > 0) {
        judge(us, us_goal, us <= us_goal);
    } else {
        std::printf(" %8.3g", us);
    }
    std::printf(" %8.3g%s", theirs_us, clipped == triangles ? "" : " (fails)");
    if (ears_goal > 0) {
        judge(us / theirs_us, ears_goal, us <= ears_goal * theirs_us);
    }
    std::printf("\n");
    std::fflush(stdout);
}

// A fine mesh of the square made coarse: points that went, a second of the whole call.
static void coarsen(double area)
{
    const drawing d = square();
    const pbw_plane_options fine = options_of(PBW_PLANE_REFINE, 30, area), coarse = options_of(0, 0, 0);
    pbw_plane_input input = pbw_plane_input();
    pbw_plane plane = pbw_plane(), result = pbw_plane();
    input.points = d.points.data();
    input.point_count = d.size();
    input.segments = d.segments.data();
    input.segment_count = d.segments.size() / 2;
    if (pbw_plane_make(&input, &fine, &plane) == PBW_OK) {
        const std::vector<double> sizes(plane.point_count, 8 * std::sqrt(area));
        const double start = seconds();
        if (pbw_plane_adapt(&plane, sizes.data(), NULL, &coarse, &result, NULL) == PBW_OK) {
            const double time = seconds() - start, gone = (double)plane.point_count - (double)result.point_count;
            std::printf("%-18s %9zu %9zu %8.3f", "coarsened square", plane.point_count, result.point_count, time);
            judge(1e-6 * gone / time, 1, 1e-6 * gone / time >= 1);
        }
    }
    std::printf("%s%s\n", plane.what, result.what);
    pbw_plane_free(&plane);
    pbw_plane_free(&result);
}

int main(int argc, char **argv)
{
    const int quick = argc > 1 && argv[1][0] == 'q', runs = quick ? 1 : 3;
    const size_t n = quick ? 100000 : 1000000;
    std::printf("%-18s %9s %9s %8s %8s\n", "small", "triangles", "pbw us", "ears us", "ratio");
    small(100, 200, 3, 0);
    small(1000, 20, 0, 1000);
    std::printf("%-18s %9s %9s %8s %8s %8s %6s\n", "constrained", "points", "segments", "pbw s", "segments", "CGAL s",
                "ratio");
    constrain("sheared", sheared(n), runs, 0.45, 0.25);
    constrain("long", crossed(n, n / 1000), runs, 0.45, 0.6);
    constrain("coasts", coasts(quick ? 10 : 32), runs, 0.45, 0.25);
    constrain("navmesh", navmesh(quick ? 158 : 500), runs, 0.5, 0.25);
    std::printf("%-18s %9s %9s %8s %8s %8s\n", "refined", "angle", "triangles", "s", "M/s", "counts");
    refine("square, area 1e-6", square(), 30, quick ? 1e-5 : 1e-6, quick ? 0 : 1585000, 2.5);
    refine("square, area 1e-6", square(), 33, quick ? 1e-5 : 1e-6, quick ? 0 : 1713000, 2.5);
    refine("plate, area 1.5e-4", plate(), 30, quick ? 1.5e-3 : 1.5e-4, 0, 2.5);
    refine("plate", plate(), 30, 0, 41700, 0);
    refine("plate", plate(), 33, 0, 62300, 0);
    refine("coast of 1000", coasts(1), 30, 0, 12900, 0);
    refine("coast of 1000", coasts(1), 33, 0, 21200, 0);
    refine("coasts", coasts(quick ? 3 : 10), 30, 0, 0, 0);
    std::printf("%-18s %9s %9s %8s %8s\n", "removal", "points", "left", "s", "M/s");
    coarsen(quick ? 1e-5 : 1e-6);
    return 0;
}
