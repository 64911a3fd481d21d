/* nearest.c: pbw nearest. */
#include "program.h"

static const option nearest_options[] = {
    { "-k", "K", "how many for each query; default 1", WHOLE, 1, 1e6, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

typedef struct found { const job *j; size_t k; const pbw_index *points; const double *distances; } found;

static void emit(void *user, FILE *file)
{
    const found *f = (const found *)user;
    size_t i, r;
    fputs("query,rank,point,distance\n", file);
    for (i = 0; i < f->j->queries.count; i++) {
        for (r = 0; r < f->k && f->points[f->k * i + r] != PBW_NONE; r++) {
            fprintf(file, "%zu,%zu,%lu,%.17g\n", i, r, (unsigned long)f->points[f->k * i + r],
                    f->distances[f->k * i + r]);
        }
    }
}

static int search(job *j)
{
    const size_t count = j->queries.count, k = (size_t)number_of(j, "-k", 1);
    const size_t room = count <= ((size_t)-1 / 16 - 1) / k ? count * k + 1 : 0;
    pbw_index *points = room > 0 ? (pbw_index *)malloc(room * sizeof *points) : NULL;
    double *distances = room > 0 ? (double *)malloc(room * sizeof *distances) : NULL;
    double start = now(), most = 0, seconds;
    found f;
    size_t i, missing = 0;
    int failed;
    if (points == NULL || distances == NULL) {
        failed = fail(j, "out of memory: %zu neighbour%s of each query", COUNT(k));
    } else {
        failed = explain(j, pbw_nearest(&j->mesh, NULL, j->queries.points, count, k, &j->build, points, distances));
    }
    if (!failed) {
        seconds = now() - start;
        for (i = 0; i < count * k; i++) {
            missing += points[i] == PBW_NONE;
            most = points[i] != PBW_NONE && distances[i] > most ? distances[i] : most;
        }
        report_step(j, "nearest", seconds, "%zu found, the farthest at %g", count * k - missing, most);
        f.j = j;
        f.k = k;
        f.points = points;
        f.distances = distances;
        failed = write_table(j, emit, &f);
    }
    free(points);
    free(distances);
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
    return status != 0 ? status : search(j);
}

const command command_nearest = {
    .name = "nearest",
    .summary = "find the points that are nearest to given ones",
    .usage =
    "usage: pbw nearest [options] points queries [-k K] [-o output.csv]...\n"
    "\n"
    "Finds for each query the K nearest points: the nearest first, equally near ones by number, in exact order.\n"
    "With --weights the distance is the power distance, squared distance minus weight.  Duplicates and points whose\n"
    "power cell is empty are not found.  All are counted from 0.\n"
    "\n"
    "input:   as for pbw mesh, both files\n"
    "output:  .csv: query, rank, point, distance; fewer than K lines for a query if there are fewer points\n"
    "\n",
    .writes = "csv",
    .options = { nearest_options, input_options, weight_options, build_options, output_options, common_options,
                 NULL },
    .run = run,
    .second = "queries",
    .may_be_flat = 1,
};
