/* gpu.cu: the same call on an NVIDIA GPU; and points that are on the device, whose triangulation stays there.
   nvcc -O3 -I. -Iexamples/lib examples/gpu.cu pbw_cuda.cu -o gpu -lpthread
   Prints the counts, the volume and the verdict (expected/gpu.txt), on the error stream who made the mesh. */
#define PBW_IMPLEMENTATION
#include "pbw.h"
#include <stdio.h>
#include <stdlib.h>

enum { COUNT = 200000 };

/* Points spread evenly over the unit cube: multiples of three irrational numbers, without their integers. */
__host__ __device__ static void place(uint32_t i, double *point)
{
    point[0] = (double)(i * 3518319155u) / 4294967296.0;
    point[1] = (double)(i * 2882110345u) / 4294967296.0;
    point[2] = (double)(i * 2360945575u) / 4294967296.0;
}

__global__ void place_all(double *points)
{
    uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i < COUNT) {
        place(i, points + 3 * (size_t)i);
    }
}

/* Adds the volumes of all tetrahedra. */
__global__ void add_volumes(pbw_cuda_mesh mesh, const double *points, double *sum)
{
    size_t t = (size_t)blockIdx.x * blockDim.x + threadIdx.x;
    if (t < mesh.simplex_count) {
        const pbw_index *corner = mesh.simplices + 4 * t;
        double e[3][3];
        for (int i = 0; i < 3; i++) {
            for (int k = 0; k < 3; k++) {
                e[i][k] = points[3 * (size_t)corner[i + 1] + k] - points[3 * (size_t)corner[0] + k];
            }
        }
        atomicAdd(sum, (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1])
                      + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2])
                      + e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) / 6.0);
    }
}

/* Points and arrays in the host's memory. */
static pbw_status from_the_host(pbw_options *options)
{
    double *points = (double *)malloc(COUNT * 3 * sizeof *points);
    pbw_mesh mesh = {0};
    pbw_status status;
    if (points == NULL) {
        return PBW_ERROR_MEMORY;
    }
    for (uint32_t i = 0; i < COUNT; i++) {
        place(i, points + 3 * (size_t)i);
    }
    options->backend = pbw_cuda_backend(0);
    options->flags = PBW_BACKEND_OR_CPU;             /* where there is no GPU, or too little memory */
    status = pbw_triangulate(3, points, NULL, COUNT, options, &mesh);
    if (status == PBW_OK) {
        printf("%zu tetrahedra of %zu points\n", mesh.simplex_count, mesh.point_count);
        fprintf(stderr, "made by the %s%s\n", mesh.statistics.by_backend ? "GPU" : "CPU: ", options->message);
    }
    pbw_free(&mesh);
    free(points);
    return status;
}

/* Points and arrays in the device's memory, in the order of a stream. */
static pbw_status on_the_device(pbw_options *options)
{
    cudaStream_t stream = NULL;
    double *points = NULL, *sum = NULL, volume = 0.0;
    pbw_cuda_mesh mesh = {0};
    pbw_report report;
    pbw_status status = PBW_ERROR_BACKEND;
    if (cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking) == cudaSuccess
        && cudaMallocAsync((void **)&points, COUNT * 3 * sizeof *points, stream) == cudaSuccess
        && cudaMallocAsync((void **)&sum, sizeof *sum, stream) == cudaSuccess
        && cudaMemsetAsync(sum, 0, sizeof *sum, stream) == cudaSuccess) {
        place_all<<<(COUNT + 255) / 256, 256, 0, stream>>>(points);
        status = pbw_cuda_triangulate(3, 0, points, NULL, COUNT, options, stream, pbw_triangulate, &mesh);
        if (status == PBW_OK) {
            add_volumes<<<(unsigned)((mesh.simplex_count + 255) / 256), 256, 0, stream>>>(mesh, points, sum);
            status = pbw_cuda_check(&mesh, 0, points, NULL, options, stream, &report);
        }
        if (status == PBW_OK
            && cudaMemcpyAsync(&volume, sum, sizeof volume, cudaMemcpyDeviceToHost, stream) == cudaSuccess
            && cudaStreamSynchronize(stream) == cudaSuccess) {
            printf("on the device: %zu tetrahedra, volume %.6f, %s\n", mesh.simplex_count, volume,
                   report.valid ? "proved right" : report.what);
        }
    }
    pbw_cuda_free(&mesh, stream);
    cudaFreeAsync(points, stream);
    cudaFreeAsync(sum, stream);
    cudaStreamDestroy(stream);
    return status;
}

int main(void)
{
    char message[200] = "";
    pbw_options options = {0};
    pbw_status status;
    options.message = message;
    options.message_size = sizeof message;
    status = from_the_host(&options);
    if (status == PBW_OK) {
        status = on_the_device(&options);
    }
    if (status != PBW_OK) {
        fprintf(stderr, "%s: %s\n", pbw_status_string(status), message);
        return 1;
    }
    return 0;
}
