// oracle_cgal.cpp: the same simplices as CGAL, which has the same rule for ties: on the zoo, on random sets of many
// kinds, and CGAL against the brute-force oracle of oracle.h on small inputs; and the same constrained triangles, of
// points in general position.  Needs CGAL, GMP and MPFR.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Regular_triangulation_2.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "../pbw.h"
#define PBW_MESH2_IMPLEMENTATION
#include "../examples/lib/pbw_mesh2.h"
#include "meshes.h"
#include "small.h"
#include "test.h"

typedef CGAL::Exact_predicates_inexact_constructions_kernel kernel;
typedef std::array<unsigned, 4> simplex;                // sorted places; the last is 0 in the plane
typedef std::vector<simplex> simplices;

typedef CGAL::Delaunay_triangulation_2<kernel, CGAL::Triangulation_data_structure_2<
    CGAL::Triangulation_vertex_base_with_info_2<unsigned, kernel>>> delaunay2;
typedef CGAL::Constrained_Delaunay_triangulation_2<kernel, CGAL::Triangulation_data_structure_2<
    CGAL::Triangulation_vertex_base_with_info_2<unsigned, kernel>,
    CGAL::Constrained_triangulation_face_base_2<kernel>>> constrained2;
typedef CGAL::Regular_triangulation_2<kernel, CGAL::Triangulation_data_structure_2<
    CGAL::Triangulation_vertex_base_with_info_2<unsigned, kernel, CGAL::Regular_triangulation_vertex_base_2<kernel>>,
    CGAL::Regular_triangulation_face_base_2<kernel>>> regular2;
typedef CGAL::Delaunay_triangulation_3<kernel, CGAL::Triangulation_data_structure_3<
    CGAL::Triangulation_vertex_base_with_info_3<unsigned, kernel>>> delaunay3;
typedef CGAL::Regular_triangulation_3<kernel, CGAL::Triangulation_data_structure_3<
    CGAL::Triangulation_vertex_base_with_info_3<unsigned, kernel, CGAL::Regular_triangulation_vertex_base_3<kernel>>,
    CGAL::Regular_triangulation_cell_base_3<kernel>>> regular3;

// The number of each point's place, in lexicographic order.
static std::vector<unsigned> find_places(int dim, const double *points, size_t n)
{
    std::vector<unsigned> order(n), place(n);
    for (size_t i = 0; i < n; i++) {
        order[i] = (unsigned)i;
    }
    auto before = [=](unsigned a, unsigned b) {
        return oracle_compare_places(dim, points + a * (size_t)dim, points + b * (size_t)dim) < 0;
    };
    std::sort(order.begin(), order.end(), before);
    for (size_t i = 1; i < n; i++) {
        place[order[i]] = place[order[i - 1]] + (before(order[i - 1], order[i]) ? 1 : 0);
    }
    return place;
}

template <class triangulation> void collect(const triangulation &t, CGAL::Dimension_tag<2>, simplices &out)
{
    for (auto f = t.finite_faces_begin(); t.dimension() == 2 && f != t.finite_faces_end(); ++f) {
        out.push_back(simplex());
        for (int k = 0; k < 3; k++) {
            out.back()[(size_t)k] = f->vertex(k)->info();
        }
    }
}

template <class triangulation> void collect(const triangulation &t, CGAL::Dimension_tag<3>, simplices &out)
{
    for (auto c = t.finite_cells_begin(); t.dimension() == 3 && c != t.finite_cells_end(); ++c) {
        out.push_back(simplex());
        for (int k = 0; k < 4; k++) {
            out.back()[(size_t)k] = c->vertex(k)->info();
        }
    }
}

template <class triangulation, class dimension, class point, class make>
static simplices cgal_simplices(const std::vector<unsigned> &place, make make_point)
{
    std::vector<std::pair<point, unsigned>> all;
    for (size_t i = 0; i < place.size(); i++) {
        all.push_back(std::make_pair(make_point(i), place[i]));
    }
    triangulation t;
    simplices out;
    t.insert(all.begin(), all.end());
    collect(t, dimension(), out);
    return out;
}

static void normalize(int dim, simplices &all)
{
    for (simplex &s : all) {
        std::sort(s.begin(), s.begin() + dim + 1);
    }
    std::sort(all.begin(), all.end());
}

static simplices from_cgal(int dim, const double *p, const double *w, const std::vector<unsigned> &place)
{
    typedef kernel::Point_2 point2;
    typedef kernel::Point_3 point3;
    typedef kernel::Weighted_point_2 weighted2;
    typedef kernel::Weighted_point_3 weighted3;
    auto at2 = [=](size_t i) { return point2(p[2 * i], p[2 * i + 1]); };
    auto at3 = [=](size_t i) { return point3(p[3 * i], p[3 * i + 1], p[3 * i + 2]); };
    simplices out = dim == 2 && w == NULL ? cgal_simplices<delaunay2, CGAL::Dimension_tag<2>, point2>(place, at2)
        : dim == 2 ? cgal_simplices<regular2, CGAL::Dimension_tag<2>, weighted2>(place,
                         [=](size_t i) { return weighted2(at2(i), w[i]); })
        : w == NULL ? cgal_simplices<delaunay3, CGAL::Dimension_tag<3>, point3>(place, at3)
                    : cgal_simplices<regular3, CGAL::Dimension_tag<3>, weighted3>(place,
                          [=](size_t i) { return weighted3(at3(i), w[i]); });
    normalize(dim, out);
    return out;
}

static void check_same(int dim, const double *points, const double *weights, size_t n)
{
    std::vector<unsigned> place = find_places(dim, points, n);
    pbw_mesh mesh;
    simplices ours;
    CHECK(pbw_triangulate(dim, points, weights, n, NULL, &mesh) <= PBW_DEGENERATE);
    for (size_t i = 0; i < mesh.simplex_count; i++) {
        ours.push_back(simplex());
        for (size_t k = 0; k <= (size_t)dim; k++) {
            ours.back()[k] = place[mesh.simplices[i * (size_t)(dim + 1) + k]];
        }
    }
    normalize(dim, ours);
    pbw_free(&mesh);
    CHECK(ours == from_cgal(dim, points, weights, place));
}

static void test_oracle()
{
    if (test_begin("CGAL and brute force agree on %ld small inputs", test_count)) {
        static oracle o;
        uint64_t state = test_seed;
        for (long n = 0; n < test_count; n++) {
            unsigned char bytes[512];
            small_input in;
            simplices brute;
            for (size_t i = 0; i < sizeof bytes; i += 8) {
                uint64_t x = input_next(&state);
                memcpy(bytes + i, &x, 8);
            }
            small_decode(&in, bytes, sizeof bytes);
            if (!oracle_solve(&o, in.dim, in.count, in.points, small_weights(&in), 0)) {
                continue;
            }
            for (unsigned set = 0; set < 1u << o.places; set++) {
                if (o.simplex[set] != 0) {
                    simplex s = { { 0, 0, 0, 0 } };
                    size_t corners = 0;
                    for (unsigned k = 0; k < (unsigned)o.places; k++) {
                        if (set >> k & 1) {
                            s[corners++] = k;
                        }
                    }
                    brute.push_back(s);
                }
            }
            std::sort(brute.begin(), brute.end());
            std::vector<unsigned> place(o.place, o.place + in.count);
            if (!CHECK(brute == from_cgal(in.dim, in.points, small_weights(&in), place)) && test_faults < 4) {
                small_print(&in);
            }
        }
        test_end();
    }
}

static void test_zoo()
{
    zoo animals;
    zoo_fill(&animals);
    for (size_t i = 0; i < animals.count; i++) {
        const zoo_input *in = animals.items + i;
        if (in->finite && test_begin("CGAL: %s", in->name)) {
            check_same(in->dim, in->points, in->weights, in->count);
            test_end();
        }
    }
    zoo_free(&animals);
}

static void test_random()
{
    for (int dim = 2; dim <= 3; dim++) {
        for (int kind = 0; kind < INPUT_KINDS; kind++) {
            for (int way = -1; way < INPUT_WEIGHTS_KINDS; way++) {
                // no weights and hiding ones on all kinds of points; the others on few uniform and lattice points
                int few = way != -1 && way != INPUT_WEIGHTS_HIDING;
                int flat = way >= INPUT_WEIGHTS_FLAT && way <= INPUT_WEIGHTS_FLAT_TILTED;
                size_t n = flat || kind == INPUT_MOMENT ? 400 : few ? 3000 : dim == 2 ? 50000 : 30000;
                if (few && kind != INPUT_UNIFORM && kind != INPUT_LATTICE) {
                    continue;
                }
                if (test_begin("CGAL: %dD %s %zu%s%s", dim, input_name(kind), n, way < 0 ? "" : ", weights ",
                               way < 0 ? "" : input_weights_name(way))) {
                    std::vector<double> points(n * (size_t)dim), weights(n);
                    input_fill(kind, dim, n, test_seed, points.data());
                    if (way >= 0) {
                        input_fill_weights(way, dim, n, test_seed, points.data(), weights.data());
                    }
                    check_same(dim, points.data(), way < 0 ? NULL : weights.data(), n);
                    test_end();
                }
            }
        }
    }
}

// Every third edge of the Delaunay triangulation of the points stretched in x: they do not cross, and most of them are
// no edges of the triangulation of the points.
static std::vector<pbw_index> sheared_segments(const std::vector<double> &points)
{
    std::vector<double> stretched(points);
    std::vector<pbw_index> segments;
    pbw_mesh mesh;
    for (size_t i = 0; i < stretched.size(); i += 2) {
        stretched[i] *= 4;
    }
    CHECK_EQUAL(pbw_triangulate(2, stretched.data(), NULL, points.size() / 2, NULL, &mesh), PBW_OK);
    for (size_t i = 0, edges = 0; i < 3 * mesh.simplex_count; i++) {
        if (mesh.neighbors[i] < i / 3 && edges++ % 3 == 0) {
            segments.push_back(mesh.simplices[i - i % 3 + (i + 1) % 3]);
            segments.push_back(mesh.simplices[i - i % 3 + (i + 2) % 3]);
        }
    }
    pbw_free(&mesh);
    return segments;
}

static void check_same_constrained(const std::vector<double> &points, const std::vector<pbw_index> &segments)
{
    constrained2 t;
    std::vector<constrained2::Vertex_handle> vertex;
    simplices ours, theirs;
    pbw_plane_input input = pbw_plane_input();
    pbw_plane plane;
    for (size_t i = 0; i < points.size(); i += 2) {
        vertex.push_back(t.insert(kernel::Point_2(points[i], points[i + 1])));
        vertex.back()->info() = (unsigned)(i / 2);
    }
    for (size_t i = 0; i < segments.size(); i += 2) {
        t.insert_constraint(vertex[segments[i]], vertex[segments[i + 1]]);
    }
    collect(t, CGAL::Dimension_tag<2>(), theirs);
    input.points = points.data();
    input.point_count = points.size() / 2;
    input.segments = segments.data();
    input.segment_count = segments.size() / 2;
    CHECK_EQUAL(pbw_plane_make(&input, NULL, &plane), PBW_OK);
    for (size_t i = 0; i < plane.triangle_count; i++) {
        const pbw_index *v = plane.triangles + 3 * i;
        const simplex one = { { v[0], v[1], v[2], 0 } };
        ours.push_back(one);
    }
    pbw_plane_free(&plane);
    normalize(2, ours);
    normalize(2, theirs);
    CHECK(ours == theirs);
}

static void test_constrained()
{
    uint64_t state = test_seed;
    if (!test_begin("constrained triangles, as CGAL has them")) {
        return;
    }
    for (int round = 0; round < 40; round++) {
        std::vector<double> points(2 * (size_t)(round < 39 ? 3 + 7 * round : 20000));
        std::vector<pbw_index> segments;
        for (double &x : points) {
            x = input_uniform(&state);
        }
        segments = sheared_segments(points);
        check_same_constrained(points, segments);
        segments.clear();
        for (pbw_index i = 0; 2 * i + 3 < points.size(); i++) {      // a chain from left to right: long segments
            segments.push_back(i);
            segments.push_back(i + 1);
            points[2 * i] = (i + 0.9 * input_uniform(&state)) / (double)points.size();
        }
        points[points.size() - 2] = 1;
        check_same_constrained(points, segments);
    }
    test_end();
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 20000);
    test_oracle();
    test_zoo();
    test_random();
    test_constrained();
    return test_finish();
}
