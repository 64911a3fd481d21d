/* locate.c: pbw locate. */
#include "program.h"

typedef struct found { const job *j; const pbw_index *simplices, *facets; } found;

/* The corners of what was found: of the simplex, or of a facet of the hull, which has one fewer. */
static void emit(void *user, FILE *file)
{
    const found *f = (const found *)user;
    const pbw_mesh *mesh = &f->j->mesh;
    const size_t corners = (size_t)mesh->dim + 1;
    size_t i, k;
    fprintf(file, "query,simplex,a,b,c%s\n", mesh->dim == 3 ? ",d" : "");
    for (i = 0; i < f->j->queries.count; i++) {
        const int outside = f->simplices[i] == PBW_NONE;
        const size_t simplex = outside ? f->facets[i] / corners : f->simplices[i];
        const size_t left_out = outside ? f->facets[i] % corners : corners;
        fprintf(file, "%zu,", i);
        fprintf(file, outside ? "-1" : "%lu", (unsigned long)simplex);
        for (k = 0; k < corners; k++) {
            if (k != left_out) {
                fprintf(file, ",%lu", (unsigned long)mesh->simplices[corners * simplex + k]);
            }
        }
        fputs(outside ? ",-1\n" : "\n", file);
    }
}

static int locate(job *j)
{
    const size_t count = j->queries.count;
    pbw_index *simplices = (pbw_index *)malloc((count + 1) * sizeof *simplices);
    pbw_index *facets = (pbw_index *)malloc((count + 1) * sizeof *facets);
    pbw_status status = PBW_ERROR_MEMORY;
    found f;
    double start = now(), seconds;
    size_t i, outside = 0;
    int failed;
    if (simplices != NULL && facets != NULL) {
        status = pbw_locate(&j->mesh, j->queries.points, count, &j->build, simplices, facets);
    }
    failed = explain(j, status);
    if (!failed) {
        seconds = now() - start;
        for (i = 0; i < count; i++) {
            outside += simplices[i] == PBW_NONE;
        }
        report_step(j, "locate", seconds, "%zu inside, %zu outside", count - outside, outside);
        f.j = j;
        f.simplices = simplices;
        f.facets = facets;
        failed = write_table(j, emit, &f);
    }
    free(simplices);
    free(facets);
    return failed;
}

static int run(job *j)
{
    int status = load(j, 1);
    status = status != 0 ? status : load_queries(j);
    status = status != 0 ? status : build(j);
    if (status == 0) {
        describe(j);
    }
    return status != 0 ? status : locate(j);
}

const command command_locate = {
    .name = "locate",
    .summary = "find the simplices that have given points",
    .usage =
    "usage: pbw locate [options] points queries [-o output.csv]...\n"
    "\n"
    "Finds for each query the simplex of the triangulation of the points that has it, exactly: of several, where it\n"
    "is on a common face, the first.  All are counted from 0; simplices as in the outputs of pbw mesh.\n"
    "\n"
    "input:   as for pbw mesh, both files\n"
    "output:  .csv: query, simplex, its corners; outside of the hull the simplex is -1, and instead there are the\n"
    "         corners of a facet of the hull that sees the query, and -1\n"
    "\n",
    .writes = "csv",
    .options = { input_options, weight_options, build_options, output_options, common_options, NULL },
    .run = run,
    .second = "queries",
};
