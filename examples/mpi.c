/* mpi.c: one triangulation by many machines, over MPI: each rank reads a slice of the points; together they make what
   pbw_triangulate makes of all: see the hash, which is that of pbw hash.
   mpicc -O2 -I. -Iexamples/lib examples/mpi.c -o mpi -lpthread -lm
   mpirun -np 8 ./mpi points.bin [--dim 2] [--weights w] [--threads 2] [--memory-limit BYTES] [-o mesh.pbwt]
   mpirun -np 8 ./mpi --generate 1000000                         a million uniform points for each rank
   points.bin: doubles x y (z) (weight).  mesh.pbwt: see pbw_tilefile.h.  Threads: the node's cores / its ranks.
   With -DMPI_CUDA=4 and pbw_cuda.o each rank builds on one of the 4 devices of its node. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#define PBW_TILES_IMPLEMENTATION
#include "pbw_tiles.h"
#define PBW_TILEFILE_IMPLEMENTATION
#include "pbw_tilefile.h"
#define PBW_MPI_IMPLEMENTATION
#include "pbw_mpi.h"
#include <float.h>
#include <signal.h>

typedef struct slice { pbwt_point *point; uint64_t first, count; } slice;
static const char *argument(int argc, char **argv, const char *name)
{
    int i = 1;
    while (i + 1 < argc && strcmp(argv[i], name) != 0) {
        i++;
    }
    return i + 1 < argc ? argv[i + 1] : NULL;
}

static size_t number(int argc, char **argv, const char *name)
{
    return argument(argc, argv, name) != NULL ? (size_t)strtoull(argument(argc, argv, name), NULL, 10) : 0;
}

/* A number from 0 to 1 that depends on i alone, so that any number of ranks makes the same points. */
static double random_of(uint64_t i)
{
    i = (i + 1) * 0x9e3779b97f4a7c15u;
    i = (i ^ i >> 30) * 0xbf58476d1ce4e5b9u;
    i = (i ^ i >> 27) * 0x94d049bb133111ebu;
    return (double)((i ^ i >> 31) >> 11) / 9007199254740992.0;
}

static pbw_status generate(slice *s, int dim)
{
    uint64_t i;
    int k;
    s->point = (pbwt_point *)calloc((size_t)s->count + 1, sizeof *s->point);
    for (i = 0; i < s->count && s->point != NULL; i++) {
        s->point[i].id = s->first + i;
        for (k = 0; k < dim; k++) {
            s->point[i].x[k] = random_of((s->first + i) * 3 + (uint64_t)k);
        }
    }
    return s->point != NULL ? PBW_OK : PBW_ERROR_MEMORY;
}

/* Reads this rank's share of the file; says in text (400 bytes) what is wrong with it. */
static pbw_status read_slice(const char *path, int rank, int ranks, const pbwm_options *o, slice *s, char *text)
{
    const size_t dim = (size_t)o->dim, each = dim + (size_t)o->weighted;
    FILE *file = fopen(path, "rb");
    const int64_t size = file != NULL && fseek(file, 0, SEEK_END) == 0 ? pbwtf_tell(file) : -1;
    const uint64_t all = size >= 0 ? (uint64_t)size / (each * 8) : 0;
    const char *what = size < 0 ? strerror(errno) : (uint64_t)size % (each * 8) != 0 ? "truncated" : NULL;
    double row[4] = { 0, 0, 0, 0 };
    uint64_t i, k;
    s->first = all * (uint64_t)rank / (uint64_t)ranks;
    s->count = all * (uint64_t)(rank + 1) / (uint64_t)ranks - s->first;
    s->point = (pbwt_point *)calloc((size_t)s->count + 1, sizeof *s->point);
    what = what == NULL && s->point == NULL ? "out of memory" : what;
    what = what == NULL && !pbwtf_seek(file, s->first * each * 8) ? strerror(errno) : what;
    for (i = 0; i < s->count && what == NULL; i++) {
        what = fread(row, 8, each, file) != each ? "truncated" : NULL;
        for (k = 0; k < each && what == NULL; k++) {
            what = row[k] >= -DBL_MAX && row[k] <= DBL_MAX ? NULL : "a number is not finite";
        }
        memcpy(s->point[i].x, row, dim * sizeof *row);
        s->point[i].weight = o->weighted ? row[dim] : 0;
        s->point[i].id = s->first + i;
    }
    snprintf(text, 400, "rank %d: %s, point %.0f: %s", rank, path, (double)(s->first + i), what != NULL ? what : "");
    if (file != NULL) {
        fclose(file);
    }
    return what != NULL ? PBW_ERROR_ARGUMENT : PBW_OK;
}

static void print_report(const pbwm_report *r, int ranks, double read)
{
    const double points = r->points > 0 ? (double)r->points : 1, *t = r->seconds;
    printf("%d rank%s, %.0f resumed: %.0f points, %.0f simplices, hash %016llx, halo %.1f %%, %.0f rounds, "
           "%.1f bytes a point, imbalance %.3f, %.0f given up, memory %.0f bytes an own point, tiles busy %.2f to "
           "%.2f (mean %.2f) s; seconds: read %.2f, partition %.2f, trees %.2f, halo %.2f, build %.2f, rounds %.2f, "
           "leftovers %.2f, links %.2f, write %.2f\n", ranks, ranks == 1 ? "" : "s", (double)r->resumed,
           (double)r->points, (double)r->simplices, (unsigned long long)r->hash, 100 * (double)r->halo / points,
           (double)r->rounds, (double)r->sent_bytes / points, (double)r->largest * ranks / points,
           (double)r->given_up, (double)r->memory * ranks / points, r->busy[0], r->busy[2], r->busy[1], read,
           t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7]);
}

int main(int argc, char **argv)
{
    const char *input = argc > 1 && argv[1][0] != '-' ? argv[1] : NULL;
    static pbwm_options options;
    static pbwm_report report;
    slice mine = { NULL, 0, 0 };
    pbw_status status = PBW_OK;
    double start;
    int rank, ranks;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    options.build.threads = (int)number(argc, argv, "--threads");
    options.build.memory_limit = number(argc, argv, "--memory-limit");
    options.dim = number(argc, argv, "--dim") == 2 ? 2 : 3;
    options.weighted = argument(argc, argv, "--weights") != NULL;
    options.output = argument(argc, argv, "-o");
#ifdef MPI_CUDA
    options.build.backend = pbw_cuda_backend(rank % MPI_CUDA);
    options.build.flags = PBW_BACKEND_OR_CPU;
#endif
    start = MPI_Wtime();
    if (input != NULL) {
        status = read_slice(input, rank, ranks, &options, &mine, report.text);
    } else {
        mine.first = (mine.count = number(argc, argv, "--generate")) * (uint64_t)rank;
        status = mine.count > 0 ? generate(&mine, options.dim) : PBW_ERROR_ARGUMENT;
        snprintf(report.text, 400, mine.count > 0 ? "rank %d: no memory for its points"
                 : "usage: mpi points.bin [-o mesh.pbwt], or mpi --generate N; see mpi.c", rank);
    }
    start = MPI_Wtime() - start;
    status = pbwm_agree(MPI_COMM_WORLD, status, report.text, sizeof report.text);
    if (argument(argc, argv, "--die") != NULL && number(argc, argv, "--die") == (size_t)rank) {
        raise(SIGKILL);                              /* for a test: the others must end, too */
    }
    options.taken = free;
    options.taken_user = mine.point;
    if (status == PBW_OK) {
        status = pbwm_triangulate(MPI_COMM_WORLD, mine.point, (size_t)mine.count, &options, &report);
    } else {
        free(mine.point);
    }
    if (rank == 0 && status != PBW_OK) {
        fprintf(stderr, "mpi: %s\n", report.text);
    } else if (rank == 0) {
        print_report(&report, ranks, start);
    }
    MPI_Finalize();
    return status != PBW_OK;
}
