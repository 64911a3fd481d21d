/* oracle_voro.cpp: volumes and centroids of cells in a box, and in a periodic one, beside those of voro++. */
#define PBW_CELLS_IMPLEMENTATION
#include "pbw_cells.h"
#include "inputs.h"
#include "test.h"
#include <vector>
#include <voro++/voro++.hh>

static void compare(int kind, size_t count, bool periodic)
{
    const char *const suffix = periodic ? ", periodic" : "";
    if (test_begin("voro++: %s, %d points%s", input_name(kind), static_cast<int>(count), suffix)) {
        std::vector<double> x(3 * count);
        const double box[6] = { 0, 0, 0, 1, 1, 1 };
        pbw_domain domain = pbw_domain();
        pbw_mesh mesh = pbw_mesh();
        pbw_cells cells;
        voro::container rival(0, 1, 0, 1, 0, 1, 8, 8, 8, periodic, periodic, periodic, 8);
        voro::c_loop_all loop(rival);
        voro::voronoicell cell;
        size_t seen = 0;
        input_fill(kind, 3, count, test_seed, x.data());
        for (size_t i = 0; i < count; i++) {
            for (size_t k = 0; k < 3; k++) {
                x[3 * i + k] = kind == INPUT_SPHERE ? 0.5 + 0.4 * x[3 * i + k] : 0.01 + 0.98 * x[3 * i + k];
            }
            rival.put(static_cast<int>(i), x[3 * i], x[3 * i + 1], x[3 * i + 2]);
        }
        domain.box = box;
        domain.periodic = periodic ? 7 : 0;
        if (periodic) {
            CHECK_EQUAL(pbw_cells_periodic(3, x.data(), NULL, count, &domain, 0, NULL, &cells), PBW_OK);
        } else {
            CHECK_EQUAL(pbw_triangulate(3, x.data(), NULL, count, NULL, &mesh), PBW_OK);
            CHECK_EQUAL(pbw_cells_of(&mesh, &domain, 0, NULL, &cells), PBW_OK);
        }
        if (loop.start()) do {
            if (rival.compute_cell(cell, loop)) {
                const size_t i = static_cast<size_t>(loop.pid());
                double c[3];
                cell.centroid(c[0], c[1], c[2]);
                CHECK(std::fabs(cell.volume() - cells.volumes[i]) < 1e-9 / static_cast<double>(count));
                for (size_t k = 0; k < 3; k++) {
                    CHECK(std::fabs(x[3 * i + k] + c[k] - cells.centroids[3 * i + k]) < 1e-9);
                }
                seen++;
            }
        } while (loop.inc());
        CHECK_EQUAL(seen, count);
        pbw_cells_free(&cells);
        pbw_free(&mesh);
        test_end();
    }
}

int main(int argc, char **argv)
{
    test_start(argc, argv, 0);
    for (int periodic = 0; periodic < 2; periodic++) {
        compare(INPUT_UNIFORM, 20, periodic != 0);
        compare(INPUT_UNIFORM, 5000, periodic != 0);
        compare(INPUT_SPHERE, 500, periodic != 0);
    }
    return test_finish();
}
