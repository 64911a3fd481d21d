/* rival_tetgen.cpp: TetGen's Delaunay tetrahedralization (3D, one thread)

   Only the tetrahedra are asked for; TetGen's neighbours, nodes and faces would cost more.  Its tie rule is not ours,
   so on degenerate points its number of tetrahedra may differ. */
#include "bench.h"

#define TETLIBRARY                         /* the header of the library, not of the program */
#include <tetgen.h>

#include <cstring>
#include <memory>

namespace {

struct job {
    tetgenbehavior options;
    tetgenio points;
    std::unique_ptr<tetgenio> result;
};

int fits(const bench_input *input)
{
    return input->dim == 3 && input->threads == 1 && !input->weights && input->count <= 10000000;
}

void *prepare(const bench_input *input)
{
    static char switches[] = "QNF";                          /* quiet, no nodes, no faces */
    job *made = new job;
    made->options.parse_commandline(switches);
    made->points.numberofpoints = int(input->count);
    made->points.pointlist = new REAL[input->count * 3];     /* tetgenio deletes it */
    std::memcpy(made->points.pointlist, input->points, input->count * 3 * sizeof(double));
    return made;
}

void build(void *that)
{
    job *made = static_cast<job *>(that);
    made->result.reset(new tetgenio);
    tetrahedralize(&made->options, &made->points, made->result.get());
}

void discard(void *that)
{
    static_cast<job *>(that)->result.reset();
}

void report(void *that, bench_sample *sample)
{
    sample->simplices = std::size_t(static_cast<job *>(that)->result->numberoftetrahedra);
}

} // namespace

const bench_side bench_tetgen = { "TetGen", 0, fits, prepare, build, discard, report };
