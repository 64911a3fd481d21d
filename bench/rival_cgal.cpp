/* rival_cgal.cpp: CGAL's Delaunay and regular triangulations, the way its manual calls fastest

   The kernel is Epick (exact predicates, doubles as coordinates); the points go in as one range, so that CGAL sorts
   them along its own Hilbert curve, and carry no indices, which would cost time.  CGAL is one thread; CGAL-TBB is the
   parallel range insertion of its 3D classes, with the lock grid of its manual (50 cells a side). */
#include "bench.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Regular_triangulation_2.h>
#include <CGAL/Regular_triangulation_3.h>

#include <memory>
#include <vector>

namespace {

typedef CGAL::Exact_predicates_inexact_constructions_kernel kernel;

struct job {
    virtual ~job() {}
    virtual void build() = 0;
    virtual void discard() = 0;
    virtual std::size_t simplices() const = 0;
};

kernel::Point_2 make_point(const double *p, const double *, kernel::Point_2 *)
{
    return kernel::Point_2(p[0], p[1]);
}

kernel::Point_3 make_point(const double *p, const double *, kernel::Point_3 *)
{
    return kernel::Point_3(p[0], p[1], p[2]);
}

kernel::Weighted_point_2 make_point(const double *p, const double *w, kernel::Weighted_point_2 *)
{
    return kernel::Weighted_point_2(kernel::Point_2(p[0], p[1]), *w);
}

kernel::Weighted_point_3 make_point(const double *p, const double *w, kernel::Weighted_point_3 *)
{
    return kernel::Weighted_point_3(kernel::Point_3(p[0], p[1], p[2]), *w);
}

template <class point> std::vector<point> make_points(const bench_input &input)
{
    std::vector<point> points;
    points.reserve(input.count);
    for (std::size_t i = 0; i < input.count; i++) {
        const double *weight = input.weights ? input.weights + i : nullptr;
        const double *at = input.points + i * std::size_t(input.dim);
        points.push_back(make_point(at, weight, static_cast<point *>(nullptr)));
    }
    return points;
}

template <class triangulation> std::size_t count_simplices(const triangulation &t, std::integral_constant<int, 2>)
{
    return std::size_t(t.number_of_faces());
}

template <class triangulation> std::size_t count_simplices(const triangulation &t, std::integral_constant<int, 3>)
{
    return std::size_t(t.number_of_finite_cells());
}

template <int dim, class triangulation, class point> struct serial_job : job {
    std::vector<point> points;
    std::unique_ptr<triangulation> result;

    explicit serial_job(const bench_input &input) : points(make_points<point>(input)) {}
    void build() override { result.reset(new triangulation(points.begin(), points.end())); }
    void discard() override { result.reset(); }
    std::size_t simplices() const override { return count_simplices(*result, std::integral_constant<int, dim>()); }
};

typedef serial_job<2, CGAL::Delaunay_triangulation_2<kernel>, kernel::Point_2> delaunay_2;
typedef serial_job<3, CGAL::Delaunay_triangulation_3<kernel>, kernel::Point_3> delaunay_3;
typedef serial_job<2, CGAL::Regular_triangulation_2<kernel>, kernel::Weighted_point_2> regular_2;
typedef serial_job<3, CGAL::Regular_triangulation_3<kernel>, kernel::Weighted_point_3> regular_3;

int fits_serial(const bench_input *input)
{
    return input->dim == 2 || input->threads == 1;          /* 2D has no parallel version: always a row */
}

void *prepare_serial(const bench_input *input)
{
    job *made;
    if (input->dim == 2) {
        made = input->weights ? static_cast<job *>(new regular_2(*input)) : new delaunay_2(*input);
    } else {
        made = input->weights ? static_cast<job *>(new regular_3(*input)) : new delaunay_3(*input);
    }
    return made;
}

void build(void *that)
{
    static_cast<job *>(that)->build();
}

void discard(void *that)
{
    static_cast<job *>(that)->discard();
}

void report(void *that, bench_sample *sample)
{
    sample->simplices = static_cast<job *>(that)->simplices();
}

} // namespace

const bench_side bench_cgal = { "CGAL", 1, fits_serial, prepare_serial, build, discard, report };

#ifdef CGAL_LINKED_WITH_TBB
#include <tbb/global_control.h>

namespace {

template <class triangulation, class point> struct parallel_job : job {
    tbb::global_control threads;
    std::vector<point> points;
    CGAL::Bbox_3 box;
    std::unique_ptr<typename triangulation::Lock_data_structure> locks;
    std::unique_ptr<triangulation> result;

    explicit parallel_job(const bench_input &input)
        : threads(tbb::global_control::max_allowed_parallelism, std::size_t(input.threads)),
          points(make_points<point>(input))
    {
        for (const point &p : points) {
            box += p.bbox();
        }
    }
    void build() override
    {
        locks.reset(new typename triangulation::Lock_data_structure(box, 50));
        result.reset(new triangulation(points.begin(), points.end(), locks.get()));
    }
    void discard() override { result.reset(); }
    std::size_t simplices() const override { return std::size_t(result->number_of_finite_cells()); }
};

typedef CGAL::Triangulation_data_structure_3<CGAL::Triangulation_vertex_base_3<kernel>,
                                             CGAL::Delaunay_triangulation_cell_base_3<kernel>, CGAL::Parallel_tag>
    delaunay_cells;
typedef CGAL::Triangulation_data_structure_3<CGAL::Regular_triangulation_vertex_base_3<kernel>,
                                             CGAL::Regular_triangulation_cell_base_3<kernel>, CGAL::Parallel_tag>
    regular_cells;
typedef parallel_job<CGAL::Delaunay_triangulation_3<kernel, delaunay_cells>, kernel::Point_3> parallel_delaunay_3;
typedef parallel_job<CGAL::Regular_triangulation_3<kernel, regular_cells>, kernel::Weighted_point_3>
    parallel_regular_3;

int fits_parallel(const bench_input *input)
{
    return input->dim == 3 && input->threads > 1;
}

void *prepare_parallel(const bench_input *input)
{
    job *made;
    if (input->weights) {
        made = new parallel_regular_3(*input);
    } else {
        made = new parallel_delaunay_3(*input);
    }
    return made;
}

} // namespace

const bench_side bench_cgal_tbb = { "CGAL-TBB", 1, fits_parallel, prepare_parallel, build, discard, report };
#endif
