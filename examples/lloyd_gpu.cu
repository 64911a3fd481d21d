/* lloyd_gpu.cu: points of the unit square that even out on an NVIDIA GPU: each step moves all to the centroids of
   their cells (Lloyd 1982), and nothing returns to the host but what is printed.  Then the points stay, and weights
   change so that the areas become more equal: plain steps towards an optimal transport.
   nvcc -O3 -I. -Iexamples/lib examples/lloyd_gpu.cu pbw_cuda.cu -o lloyd_gpu -lpthread
   Prints how uneven the areas are (expected/lloyd_gpu.txt); with a file name, writes the points there, for
   `pbw view`. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>
#include <stdlib.h>

enum { COUNT = 100000 };

static const double box[4] = { 0, 0, 1, 1 };

/* Mixes the bits of a number. */
__device__ uint32_t mixed(uint32_t x)
{
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

__global__ void place_all(double *points, double *weights)
{
    const uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < COUNT) {
        points[2 * i] = (double)mixed(2 * i) / 4294967296.0;
        points[2 * i + 1] = (double)mixed(2 * i + 1) / 4294967296.0;
        weights[i] = 0.0;
    }
}

/* A weight grows where its cell is too small.  An area grows by less than 3.5 times what its weight gains on those
   around it, so steps do not overshoot. */
__global__ void change_weights(const double *areas, double *weights)
{
    const uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < COUNT) {
        weights[i] += 0.3 * (1.0 / COUNT - areas[i]);
    }
}

/* The mean of |area - mean area|, in parts of the mean; -1 if the copy fails. */
static double unevenness(const pbw_cuda_cells *cells, double *areas, cudaStream_t stream)
{
    double sum = 0.0;
    if (cudaMemcpyAsync(areas, cells->volumes, COUNT * sizeof *areas, cudaMemcpyDeviceToHost, stream) != cudaSuccess
        || cudaStreamSynchronize(stream) != cudaSuccess) {
        return -1.0;
    }
    for (int i = 0; i < COUNT; i++) {
        sum += fabs(areas[i] * COUNT - 1.0);
    }
    return sum / COUNT;
}

/* Steps of a loop: with weights the points stay and these change, else the points move.  Returns the last status. */
static pbw_status steps(pbw_cuda_loop *loop, pbw_cuda_points *at, double *weights, int count, double *areas,
                        cudaStream_t stream)
{
    pbw_status status = PBW_OK;
    pbw_cuda_mesh mesh;
    pbw_cuda_cells cells;
    for (int step = 0; step < count && status == PBW_OK; step++) {
        status = pbw_cuda_loop_step(loop, at, &mesh);
        if (status == PBW_OK) {
            status = pbw_cuda_loop_cells(loop, at, box, 0, &cells);
        }
        if (status == PBW_OK && (step % 10 == 0 || step + 1 == count)) {
            printf("%s %2d: areas differ by %.2f of their mean\n", weights != NULL ? "weights" : "points", step,
                   unevenness(&cells, areas, stream));
        }
        if (status == PBW_OK && weights != NULL) {
            change_weights<<<(COUNT + 255) / 256, 256, 0, stream>>>(cells.volumes, weights);
        } else if (status == PBW_OK) {
            at->points = cells.centroids;
        }
    }
    return status;
}

static void write_points(const char *name, const double *points)
{
    FILE *file = fopen(name, "w");
    for (int i = 0; i < COUNT && file != NULL; i++) {
        fprintf(file, "%.17g,%.17g\n", points[2 * i], points[2 * i + 1]);
    }
    if (file == NULL || fclose(file) != 0) {
        fprintf(stderr, "%s: cannot be written\n", name);
    }
}

int main(int argc, char **argv)
{
    char message[200] = "";
    pbw_options options = {0};
    pbw_cuda_points at = {0};
    pbw_cuda_loop *loop = NULL;
    pbw_status status = PBW_ERROR_BACKEND;
    cudaStream_t stream = NULL;
    double *points = NULL, *fixed = NULL, *weights = NULL, *host = (double *)malloc(2 * COUNT * sizeof *host);
    options.message = message;
    options.message_size = sizeof message;
    if (host != NULL && cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking) == cudaSuccess
        && cudaMallocAsync((void **)&points, 2 * COUNT * sizeof *points, stream) == cudaSuccess
        && cudaMallocAsync((void **)&fixed, 2 * COUNT * sizeof *fixed, stream) == cudaSuccess
        && cudaMallocAsync((void **)&weights, COUNT * sizeof *weights, stream) == cudaSuccess) {
        place_all<<<(COUNT + 255) / 256, 256, 0, stream>>>(points, weights);
        at.dim = 2;
        at.count = COUNT;
        at.points = points;
        status = pbw_cuda_loop_create(&options, stream, pbw_triangulate, &loop);
    }
    if (status == PBW_OK) {
        status = steps(loop, &at, NULL, 41, host, stream);
    }
    if (status == PBW_OK) {                          /* the centroids belong to the loop: kept for the weights */
        cudaMemcpyAsync(fixed, at.points, 2 * COUNT * sizeof *fixed, cudaMemcpyDeviceToDevice, stream);
        at.points = fixed;
        at.weights = weights;
        status = steps(loop, &at, weights, 41, host, stream);
    }
    if (status == PBW_OK && argc > 1
        && cudaMemcpyAsync(host, fixed, 2 * COUNT * sizeof *host, cudaMemcpyDeviceToHost, stream) == cudaSuccess
        && cudaStreamSynchronize(stream) == cudaSuccess) {
        write_points(argv[1], host);
    }
    if (status != PBW_OK) {
        fprintf(stderr, "%s: %s\n", pbw_status_string(status), message);
    }
    pbw_cuda_loop_free(loop);
    cudaFreeAsync(points, stream);
    cudaFreeAsync(fixed, stream);
    cudaFreeAsync(weights, stream);
    cudaStreamDestroy(stream);
    free(host);
    return status != PBW_OK;
}
