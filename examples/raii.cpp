/* raii.cpp: pbw.h from C++: a class that owns its mesh, std::vector in, exceptions out, a lambda for the progress.
   c++ -std=c++11 -O2 -I. examples/raii.cpp -o raii -lpthread
   Prints expected/raii.txt. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <array>
#include <cstdio>
#include <exception>
#include <functional>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

namespace pbw {

class error : public std::runtime_error
{
public:
    explicit error(pbw_status s) : std::runtime_error(pbw_status_string(s)), status(s) {}
    const pbw_status status;
};

/* Dim is 2 or 3.  Points that span less than that give an empty triangulation, without an exception. */
template <std::size_t Dim>
class triangulation
{
public:
    typedef std::array<double, Dim> point;
    typedef std::array<pbw_index, Dim + 1> simplex;

    /* progress: a stage and the share of it that is done; what it throws ends the build and is thrown on. */
    explicit triangulation(const std::vector<point> &points, const std::vector<double> &weights = {},
                           const std::function<void(pbw_stage, double)> &progress = nullptr)
        : mesh_()
    {
        caller on = { progress, nullptr };
        pbw_options options = pbw_options();
        pbw_status status;
        if (!weights.empty() && weights.size() != points.size()) {
            throw std::invalid_argument("one weight a point, or none");
        }
        if (progress) {
            options.progress = call;
            options.progress_user = &on;
        }
        status = pbw_triangulate(static_cast<int>(Dim), points.empty() ? nullptr : points.data()->data(),
                                 weights.empty() ? nullptr : weights.data(), points.size(), &options, &mesh_);
        if (on.thrown) {
            pbw_free(&mesh_);
            std::rethrow_exception(on.thrown);
        }
        if (status == PBW_ERROR_MEMORY) {
            throw std::bad_alloc();
        }
        if (status != PBW_OK && status != PBW_DEGENERATE) {
            throw error(status);
        }
    }

    ~triangulation() { pbw_free(&mesh_); }
    triangulation(const triangulation &) = delete;
    triangulation(triangulation &&other) noexcept : mesh_(other.mesh_) { other.mesh_ = pbw_mesh(); }
    triangulation &operator=(triangulation other) noexcept
    {
        std::swap(mesh_, other.mesh_);
        return *this;
    }

    std::size_t size() const { return mesh_.simplex_count; }
    simplex operator[](std::size_t i) const { return corners(mesh_.simplices, i); }
    simplex neighbors(std::size_t i) const { return corners(mesh_.neighbors, i); }     /* PBW_NONE: outside */
    const pbw_mesh &mesh() const { return mesh_; }                                     /* for the C functions */

private:
    struct caller {
        const std::function<void(pbw_stage, double)> &progress;
        std::exception_ptr thrown;
    };

    /* Exceptions must not pass through C: they wait here, and the build is cancelled. */
    static int call(void *user, pbw_stage stage, double done)
    {
        caller *on = static_cast<caller *>(user);
        try {
            on->progress(stage, done);
        } catch (...) {
            on->thrown = std::current_exception();
        }
        return on->thrown != nullptr;
    }

    static simplex corners(const pbw_index *array, std::size_t i)
    {
        simplex s;
        for (std::size_t k = 0; k < s.size(); k++) {
            s[k] = array[s.size() * i + k];
        }
        return s;
    }

    pbw_mesh mesh_;
};

}  // namespace pbw

int main()
{
    typedef pbw::triangulation<3> triangulation;
    std::vector<triangulation::point> points;
    unsigned long long state = 1;
    for (int i = 0; i < 100000; i++) {
        triangulation::point p;
        for (double &x : p) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            x = static_cast<double>(state >> 11) / 9007199254740992.0;
        }
        points.push_back(p);
    }
    try {
        triangulation first(points), second(std::move(first));
        std::size_t hull = 0;
        for (std::size_t i = 0; i < second.size(); i++) {
            for (pbw_index n : second.neighbors(i)) {
                hull += n == PBW_NONE;
            }
        }
        std::printf("%zu tetrahedra, %zu hull facets; %zu left in what was moved from\n", second.size(), hull,
                    first.size());
        second = triangulation(std::vector<triangulation::point>(points.begin(), points.begin() + 4));
        std::printf("of four points: %zu\n", second.size());
        triangulation(points, {}, [](pbw_stage stage, double done) {
            if (stage == PBW_STAGE_BUILD && done > 0.5) {
                throw std::runtime_error("half-way is enough");
            }
        });
    } catch (const std::exception &e) {
        std::printf("exception: %s\n", e.what());
    }
    try {
        points[7][1] = std::numeric_limits<double>::infinity();
        triangulation bad(points);
    } catch (const pbw::error &e) {
        std::printf("error %d: %s\n", e.status, e.what());
    }
    return 0;
}
