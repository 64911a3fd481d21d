/* io_samples.h: a small good file of every kind that pbw_io.h reads, and what it must give. */
#ifndef IO_SAMPLES_H
#define IO_SAMPLES_H

#include <stdint.h>
#include <string.h>

typedef struct io_sample {
    const char *name, *data;
    size_t size;
    int dim;
    size_t points, triangles;
    double sum;                             /* of all coordinates */
} io_sample;

#define IO_TEXT(name, text, dim, points, triangles, sum) { name, text, sizeof text - 1, dim, points, triangles, sum }

static const io_sample io_text_samples[] = {
    IO_TEXT("plain.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1", 3, 4, 0, 3),
    IO_TEXT("flat.txt", "# two columns\n\n0\t0\r\n1\t0\r\n0.5\t1e0\r\n", 2, 3, 0, 2.5),
    IO_TEXT("count.pts", "2\n1 2 3 200 10 20 30\n-4 5 6 100 1 2 3\n", 3, 2, 0, 13),
    IO_TEXT("names.csv", "id,x,y,z,name\n7, 1 ,2,3,\"a, b\"\n8,4,5,6,c\n", 3, 2, 0, 21),
    IO_TEXT("semicolons.csv", "1;2;3\n4;5;6\n", 3, 2, 0, 21),
    IO_TEXT("bom.csv", "\xef\xbb\xbf" "x,y\n1,2\n3,4\n", 2, 2, 0, 10),
    IO_TEXT("fortran.dat", "  1.5D+01  -.5d0  +2.\n  1E1 0 0\n", 3, 2, 0, 26.5),
    IO_TEXT("tetrahedron.obj", "# model\nmtllib a.mtl\nv 0 0 0\nv 1 0 0 1\nv 0 1 0 .5 .5 .5\nv 0 0 1\n"
            "vn 0 0 1\nvt 0 0\no thing\nf 1/1/1 3//1 2/1\nf 1 2 4\nf -4 -1 -2\nf 2 3 \\\n 4\n", 3, 4, 4, 3),
    IO_TEXT("quad.obj", "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 2 3 4\n", 3, 4, 2, 8),
    IO_TEXT("windows.obj", "v 0 0 1\r\nv 1 0 \\\r\n1\r\nv 1 1 1\r\nf 1 2 \\\r\n 3\r\n", 3, 3, 1, 6),
    IO_TEXT("square.off", "OFF # comment\n4 1 4\n0 0 0\n1 0 0\n1 1 0\n\n0 1 0\n4 0 1 2 3 255 0 0\n", 3, 4, 2, 4),
    IO_TEXT("colours.off", "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n3 0 1 2\n",
            3, 3, 1, 2),
    IO_TEXT("bare.off", "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", 3, 3, 1, 2),
    IO_TEXT("zero.node", "4 3 1 1\n# comment\n0 0 0 0 0.5 1\n1 1 0 0 0.5 1\n2 0 1 0 0.25 0\n3 0 0 1 0 0\n",
            3, 4, 0, 3),
    IO_TEXT("one.node", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n", 2, 3, 0, 2),
    IO_TEXT("text.stl", "solid name\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
            "endloop\nendfacet\nendsolid name\n", 3, 3, 1, 2),
    IO_TEXT("text.ply", "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float nx\n"
            "property float x\nproperty float y\nproperty list uchar int tags\nproperty double z\nelement face 2\n"
            "property list uchar int vertex_indices\nelement edge 1\nproperty int a\nend_header\n"
            "nan 0 0 0 0\n0 1 0 1 9 0\n0 1 1 0 0\n0 0 1 2 7 8 0\n4 0 1 2 3\n3 0 1 2\n5\n", 3, 4, 3, 4),
    IO_TEXT("flat.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty int y\nproperty int x\nend_header\n7 5\n",
            2, 1, 0, 12)
};

#define IO_TEXT_SAMPLES ((int)(sizeof io_text_samples / sizeof io_text_samples[0]))
#define IO_SAMPLES (IO_TEXT_SAMPLES + 3)

static size_t io_append(char *out, size_t at, uint64_t bits, int size, int big)
{
    int i;
    for (i = 0; i < size; i++) {
        out[at + (size_t)i] = (char)(bits >> 8 * (big ? size - 1 - i : i));
    }
    return at + (size_t)size;
}

/* A triangle as binary .ply: vertices of float x, double y, int16 z and a list to skip; then a face. */
static size_t io_binary_ply(char *out, int big)
{
    static const double xyz[3][3] = { { 0.5, 0, -3 }, { 1, 0.25, 0 }, { 0, 1, 300 } };
    size_t at, i;
    strcpy(out, "ply\nformat ");
    strcat(out, big ? "binary_big_endian" : "binary_little_endian");
    strcat(out, " 1.0\nelement camera 2\nproperty uint32 a\nproperty uchar b\nelement vertex 3\nproperty float x\n"
           "property double y\nproperty list uint8 short tags\nproperty short z\nelement face 1\n"
           "property list uchar uint vertex_index\nend_header\n");
    at = strlen(out);
    for (i = 0; i < 10; i++) {
        at = io_append(out, at, i, 1, 0);
    }
    for (i = 0; i < 3; i++) {
        float x = (float)xyz[i][0];
        uint32_t x_bits;
        uint64_t y_bits;
        memcpy(&x_bits, &x, 4);
        memcpy(&y_bits, &xyz[i][1], 8);
        at = io_append(out, at, x_bits, 4, big);
        at = io_append(out, at, y_bits, 8, big);
        at = io_append(out, at, i == 1, 1, big);
        at = io_append(out, at, 77, i == 1 ? 2 : 0, big);
        at = io_append(out, at, (uint64_t)(int64_t)xyz[i][2], 2, big);
    }
    at = io_append(out, at, 3, 1, big);
    for (i = 0; i < 3; i++) {
        at = io_append(out, at, i, 4, big);
    }
    return at;
}

static size_t io_binary_stl(char *out)
{
    static const float corner[24] = { 0, 0, 1,  0, 0, 0,  1, 0, 0,  0, 1, 0,  0, 0, 1,  1, 0, 0,  1, 1, 0,  0, 1, 0 };
    size_t at = 80, i;
    memset(out, 0, 80);
    memcpy(out, "solid all the same", 18);
    at = io_append(out, at, 2, 4, 0);
    for (i = 0; i < 24; i++) {
        uint32_t bits;
        memcpy(&bits, &corner[i], 4);
        at = io_append(out, at, bits, 4, 0);
        at = io_append(out, at, 0, i % 12 == 11 ? 2 : 0, 0);
    }
    return at;
}

/* Sample number i < IO_SAMPLES; buffer: 1024 bytes for the binary ones. */
static io_sample io_get_sample(int i, char *buffer)
{
    io_sample s;
    memset(&s, 0, sizeof s);
    if (i < IO_TEXT_SAMPLES) {
        return io_text_samples[i];
    }
    i -= IO_TEXT_SAMPLES;
    s.name = i == 0 ? "little.ply" : i == 1 ? "big.ply" : "binary.stl";
    s.data = buffer;
    s.size = i == 2 ? io_binary_stl(buffer) : io_binary_ply(buffer, i);
    s.dim = 3;
    s.points = i == 2 ? 6 : 3;
    s.triangles = i == 2 ? 2 : 1;
    s.sum = i == 2 ? 6 : 299.75;
    return s;
}

#endif
