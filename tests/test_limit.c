/* test_limit.c: more simplices than can be numbered, with a limit so low that small inputs reach it, and odd, as
   a new point of the plane takes two. */
#define PBW_IMPLEMENTATION
#define PBW__TEST_SIMPLEX_LIMIT 2999
#include "../pbw.h"
#include "meshes.h"
#include "meter.h"
#include "test.h"

int main(int argc, char **argv)
{
    double points[3 * 2000];
    int dim, kind;
    test_start(argc, argv, 0);
    for (dim = 2; dim <= 3; dim++) {
        for (kind = 0; kind < INPUT_KINDS; kind++) {
            if (test_begin("more than 2999 simplices, ghosts included: %dD %s", dim, input_name(kind))) {
                size_t n, refused = 0, done = 0;
                for (n = 10; n <= 2000; n += n / 8) {
                    meter m;
                    pbw_mesh mesh;
                    pbw_options options;
                    pbw_status status;
                    meter_start(&m, 0, 0);
                    memset(&options, 0, sizeof options);
                    options.resize = meter_resize;
                    options.resize_user = &m;
                    options.threads = 1 + (int)(n % 2) * 2;
                    input_fill(kind, dim, n, test_seed, points);
                    status = pbw_triangulate(dim, points, NULL, n, &options, &mesh);
                    if (status == PBW_OK) {
                        CHECK(mesh.simplex_count <= 2999 && meshes_fault(&mesh) == NULL);
                        done++;
                    } else {
                        CHECK_EQUAL(status, PBW_ERROR_TOO_LARGE);
                        CHECK(meshes_is_empty(&mesh));
                        refused++;
                    }
                    pbw_free(&mesh);
                    CHECK(m.blocks == 0 && m.faults == 0);
                }
                CHECK(refused > 0 && done > 0);
                test_end();
            }
        }
    }
    return test_finish();
}
