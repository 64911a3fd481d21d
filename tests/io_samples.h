/* io_samples.h: a small valid file of every kind that pbw_io.h reads, and the counts that reading must give. */
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
    IO_TEXT("box.poly", "5 3 0 1\n1 0 0 0 1\n2 2 0 0\n3 2 2 0\n4 0 2 0\n5 .5 .5 0\n2 1\n2 0 3\n4 1 2 3 4\n2 1 5\n"
            "1\n3 1 2 4\n1\n1 .5 .5 .5\n1\n1 1 1 1 7 .1\n", 3, 5, 5, 9),
    IO_TEXT("box.smesh", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 1 1 0\n3 0 1 0\n1 1\n4 0 1 2 3 5\n0\n0\n", 3, 4, 2, 4),
    IO_TEXT("text.stl", "solid name\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
            "endloop\nendfacet\nendsolid name\n", 3, 3, 1, 2),
    IO_TEXT("text.ply", "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float nx\n"
            "property float x\nproperty float y\nproperty list uchar int tags\nproperty double z\nelement face 2\n"
            "property list uchar int vertex_indices\nelement edge 1\nproperty int a\nend_header\n"
            "nan 0 0 0 0\n0 1 0 1 9 0\n0 1 1 0 0\n0 0 1 2 7 8 0\n4 0 1 2 3\n3 0 1 2\n5\n", 3, 4, 3, 4),
    IO_TEXT("flat.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty int y\nproperty int x\nend_header\n7 5\n",
            2, 1, 0, 12),
    IO_TEXT("water.xyz",
            "3\nwater, 0 K\nO 0 0 0.5\nH 0.75 0 -0.5 9\nH -0.75 1 -0.5\n", 3, 3, 0, 0.5),
    IO_TEXT("blank.xyz",
            "2\n\nC 1 2 3\nC 4 5 6\n", 3, 2, 0, 21),
    IO_TEXT("qhull.txt",
            "2\n3\n0 0\n1 0\n0 1.5\n", 2, 3, 0, 2.5),
    IO_TEXT("counts.txt",
            "4 3\n0 0 0.5\n1 0 0\n0 1 0\n0 0 1\n", 3, 4, 0, 3.5),
    IO_TEXT("list.json",
            "[[0, 0], [1.5, 0],\n [0, 1e0]]", 2, 3, 0, 2.5),
    IO_TEXT("objects.json",
            "{\"crs\": \"local\", \"points\": [{\"x\": 1, \"Y\": 2, \"z\": 3, \"tags\": [7, 8, {\"a\": null}], "
            "\"w\": 0.5},\n{\"z\": 6, \"y\": 5, \"x\": 4, \"n\": \"a \\\" ]\", \"w\": 1}]}", 3, 2, 0, 21),
    IO_TEXT("map.geojson",
            "{\"type\": \"FeatureCollection\", \"bbox\": [0, 0, 9, 9], \"features\": [{\"type\": \"Feature\", \""
            "properties\":\n{\"ids\": [7, 8]}, \"geometry\": {\"type\": \"Polygon\", \"coordinates\": [[[0, 0], "
            "[4, 0], [0, 4], [0, 0]]]}},\n{\"type\": \"Feature\", \"geometry\": {\"type\": \"Point\", \"coordina"
            "tes\": [1, 2, 3]}}]}", 2, 4, 0, 11),
    IO_TEXT("two.msh",
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"skin\"\n$EndPhysicalNames\n$Nodes\n5"
            "\n9 0 0 0\n7 1 0 0\n5 0 1 0\n3 0 0 1\n2 .5 .5 .5\n$EndNodes\n$Elements\n4\n1 15 2 1 1 9\n2 2 2 1 1 "
            "9 5 7\n3 4 2 2 1 9 7 5 3\n4 3 0 9 7 5 3\n$EndElements\n", 3, 5, 3, 4.5),
    IO_TEXT("four.msh",
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n2 4 1 4\n2 1 1 1\n4\n0 0 0 .1 .2\n3 1 0 3\n1\n2\n3\n1"
            " 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n2 2 1 2\n2 1 9 1\n1 1 2 3 4 1 2\n3 1 4 1\n2 4 1 2 3\n$End"
            "Elements\n", 3, 4, 1, 3),
    IO_TEXT("binary.msh",
            "$MeshFormat\n2.2 1 8\n\001\000\000\000\n$EndMeshFormat\n$Nodes\n4\n\001\000\000\000\000\000\000\000"
            "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\002\000\000\000"
            "\000\000\000\000\000\000\360\077\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
            "\003\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\360\077\000\000\000\000"
            "\000\000\000\000\004\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
            "\000\000\000\000\000\000\360\077\n$EndNodes\n$Elements\n2\n\004\000\000\000\001\000\000\000\001\000"
            "\000\000\007\000\000\000\001\000\000\000\001\000\000\000\002\000\000\000\003\000\000\000\004\000"
            "\000\000\002\000\000\000\001\000\000\000\000\000\000\000\002\000\000\000\001\000\000\000\002\000"
            "\000\000\003\000\000\000\n$EndElements\n", 3, 4, 1, 3),
    IO_TEXT("binary41.msh",
            "$MeshFormat\n4.1 1 8\n\001\000\000\000\n$EndMeshFormat\n$Entities\n"
            "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
            "\000\000\000\000\000\000\000\000\n$EndEntities\n$Nodes\n"
            "\001\000\000\000\000\000\000\000\004\000\000\000\000\000\000\000\001\000\000\000\000\000\000\000"
            "\004\000\000\000\000\000\000\000\003\000\000\000\001\000\000\000\000\000\000\000\004\000\000\000"
            "\000\000\000\000\004\000\000\000\000\000\000\000\003\000\000\000\000\000\000\000\002\000\000\000"
            "\000\000\000\000\001\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
            "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\360\077\000\000\000\000"
            "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
            "\000\000\360\077\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
            "\000\000\000\000\000\000\000\000\000\000\360\077\n$EndNodes\n$Elements\n\001\000\000\000\000\000"
            "\000\000\001\000\000\000\000\000\000\000\001\000\000\000\000\000\000\000\001\000\000\000\000\000"
            "\000\000\003\000\000\000\001\000\000\000\004\000\000\000\001\000\000\000\000\000\000\000\001\000"
            "\000\000\000\000\000\000\004\000\000\000\000\000\000\000\003\000\000\000\000\000\000\000\002\000"
            "\000\000\000\000\000\000\001\000\000\000\000\000\000\000\n$EndElements\n", 3, 4, 0, 3),
    IO_TEXT("medit.mesh",
            "MeshVersionFormatted 2\nDimension\n3\n# points\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 -1\n0 0 1 1\nE"
            "dges 1\n1 2 1\nTriangles\n1\n1 3 2 1\nTetrahedra 1 1 2 3 4 2\nQuadrilaterals 1\n1 2 3 4 0\nEnd\n",
            3, 4, 3, 3),
    IO_TEXT("text.vtu",
            "<\077xml version=\"1.0\"\077>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"Litt"
            "leEndian\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"4\" NumberOfCells=\"2\">\n<Points><DataArr"
            "ay type=\"Float32\" Name=\"p\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0\n0 1 0 0 0 1</"
            "DataArray></Points>\n<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 "
            "3 0 2 1</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4 7</DataArray>\n<"
            "DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 5</DataArray></Cells>\n</Piece></Unstru"
            "cturedGrid></VTKFile>\n", 3, 4, 1, 3),
    IO_TEXT("base64.vtu",
            "<\077xml version=\"1.0\"\077>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"Litt"
            "leEndian\" header_type=\"UInt32\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"4\" NumberOfCells="
            "\"2\">\n<Points><DataArray type=\"Float32\" Name=\"p\" NumberOfComponents=\"3\" format=\"binary\">"
            "\nMAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPw==\n</DataArray></Points>\n"
            "<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"binary\">\nHAAAAAAAAAABAAAAAgAAAAMA"
            "AAAAAAAAAgAAAAEAAAA=\n</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"binary\">\n"
            "EAAAAAQAAAAAAAAABwAAAAAAAAA=\n</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"binar"
            "y\">\nAgAAAAoF\n</DataArray></Cells>\n</Piece></UnstructuredGrid></VTKFile>\n", 3, 4, 1, 3),
    IO_TEXT("zlib.vtu",
            "<\077xml version=\"1.0\"\077>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"Litt"
            "leEndian\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"4\" N"
            "umberOfCells=\"2\">\n<Points><DataArray type=\"Float32\" Name=\"p\" NumberOfComponents=\"3\" format"
            "=\"binary\">AgAAACAAAAAQAAAAEAAAAA0AAAA=eJxjYEAGDfYMaHwADo4Bf3icY2BABg32AAFPAMA=</DataArray></Point"
            "s>\n<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"binary\">AQAAAEAAAAAcAAAAFwAAAA"
            "==eJxjYGBgYARiJiBmZoAAJqgYAACgAAo=</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format="
            "\"binary\">AQAAAEAAAAAQAAAADgAAAA==eJxjYYAAdigNAACIAAw=</DataArray>\n<DataArray type=\"UInt8\" Name"
            "=\"types\" format=\"binary\">AQAAAEAAAAACAAAACgAAAA==eJzjYgUAABsAEA==</DataArray></Cells>\n</Piece>"
            "</UnstructuredGrid></VTKFile>\n", 3, 4, 1, 3),
    IO_TEXT("raw.vtu",
            "<\077xml version=\"1.0\"\077>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"Litt"
            "leEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"4\" NumberOfCells="
            "\"2\">\n<Points><DataArray type=\"Float32\" Name=\"p\" NumberOfComponents=\"3\" format=\"appended\""
            " offset=\"0\"></DataArray></Points>\n<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format="
            "\"appended\" offset=\"56\"></DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"append"
            "ed\" offset=\"92\"></DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"appended\" offse"
            "t=\"116\"></DataArray></Cells>\n</Piece></UnstructuredGrid><AppendedData encoding=\"raw\">_0\000"
            "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200\077\000\000"
            "\000\000\000\000\000\000\000\000\000\000\000\000\200\077\000\000\000\000\000\000\000\000\000\000"
            "\000\000\000\000\200\077\034\000\000\000\000\000\000\000\000\000\000\000\001\000\000\000\002\000"
            "\000\000\003\000\000\000\000\000\000\000\002\000\000\000\001\000\000\000\020\000\000\000\000\000"
            "\000\000\004\000\000\000\000\000\000\000\007\000\000\000\000\000\000\000\002\000\000\000\000\000"
            "\000\000\n\005</AppendedData></VTKFile>\n", 3, 4, 1, 3),
    IO_TEXT("text.vtk",
            "# vtk DataFile Version 5.1\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0\n0 1 0 "
            "0 0 1\nCELLS 3 8\nOFFSETS vtktypeint64\n0 4 8\nCONNECTIVITY vtktypeint64\n0 1 2 3 0 1 2 3\n"
            "CELL_TYPES 2\n10 9\nCELL_DATA 2\nFIELD FieldData 1\nregion 1 2 int\n4 5\n", 3, 4, 2, 3),
    IO_TEXT("binary.vtk",
            "# vtk DataFile Version 3.0\ntitle\nBINARY\nDATASET POLYDATA\nPOINTS 3 float\n\000\000\000\000\000\000"
            "\000\000\000\000\000\000\077\200\000\000\000\000\000\000\000\000\000\000\000\000\000\000\077\200\000\000"
            "\000\000\000\000\nPOLYGONS 1 4\n\000\000\000\003\000\000\000\000\000\000\000\001\000\000\000\002\n"
            "CELL_DATA 1\nSCALARS region short\nLOOKUP_TABLE default\n\000\007\n", 3, 3, 1, 2),
    IO_TEXT("concave.off", "OFF\n8 1 0\n0 0 0\n7 0 0\n7 6 0\n5 6 0\n5 2 0\n2 2 0\n2 6 0\n0 6 0\n8 7 6 5 4 3 2 1 0\n",
            3, 8, 6, 56),
    IO_TEXT("upper.stl", " SOLID A\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 0\n"
            "END LOOP\nEND FACET\nEND SOLID\n", 3, 3, 1, 2),
    IO_TEXT("sets.inp", "*HEADING\n a bar\n*NODE, NSET=NALL\n10,0,0,0\n20,1,0,0\n30,0,1,0\n40,0,0,1\n50,1,1,1\n*ELEMENT, "
            "TYPE=C3D4, ELSET=a\n1,10,20,30,40\n2,20,50,30,\n40\n*ELEMENT,TYPE=S3\n3,10,20,30\n*ELSET,ELSET=b,GENERATE\n"
            "2,4,2\n*ELSET,ELSET=c\n a, b\n*SURFACE, NAME=\"top\"\n1,S1\nb,S3\n*NSET,NSET=n\n10,20\n", 3, 5, 3, 6),
    IO_TEXT("markers.su2", "% square\nNDIME= 2\nNELEM= 2\n5 0 1 2 0\n5 0 2 3 1\nNPOIN= 4\n0 0 0\n1 0 1\n1 1 2\n0 1 3\n"
            "NMARK= 1\nMARKER_TAG= low\nMARKER_ELEMS= 1\n3 0 1\n", 2, 4, 2, 4),
    IO_TEXT("graph.json", "{\"edges\": [[0, 1], [1, 2]], \"points\": [[0, 0], [1, 0], [0, 1]]}", 2, 3, 0, 2),
    IO_TEXT("stations.csv", "id,easting,northing,height\n1,0,0,5\n2,4,0,6\n3,0,4,7\n", 3, 3, 0, 26),
    IO_TEXT("named.csv.gz",
            "\037\213\010\010\000\000\000\000\002\377points.csv\0005\220I\016\3030\024B\3679\313W\345\077x\272Y"
            "\232\323\267rx\312\002L\000#\337\366\265\347j\366\377>\375r\363\203eq0,\205%\275\3137\0166\233:/"
            "\375\337\362{\203\320\350\301\025\251\254\027J\3073HM\010\305\276e\216\246x8J0\232\265Q\020\232c`"
            "\236\304\027\312\226'\331\234\016\2419S\346,\305\223\227\310\201\207\315\271 o\363\017S\373\343Wd"
            "\001\000\000", 3, 40, 0, 879.0),
    IO_TEXT("members.xyz.gz",
            "\037\213\010\000\000\000\000\000\000\377\001\014\000\363\3770 0 0\n1 0 0\n\264\351\315\333\014\000"
            "\000\000\037\213\010\000\000\000\000\000\000\3773P0T0\3402P0P0\304B\002\000o\351\336\017\036\000"
            "\000\000\000\000", 3, 7, 0, 6)
};

#define IO_TEXT_SAMPLES ((int)(sizeof io_text_samples / sizeof io_text_samples[0]))
#define IO_SAMPLES (IO_TEXT_SAMPLES + 3)

/* The most bytes that a reader of a file may hold.  Deflate packs 1032 bytes into one at best. */
static size_t io_bound(const void *data, size_t size)
{
    const char *text = (const char *)data;
    int packed = size >= 2 && memcmp(text, "\x1f\x8b", 2) == 0;
    size_t i, n = size;
    for (i = 0; i + 20 < size && !packed; i++) {
        packed = memcmp(text + i, "vtkZLibDataCompressor", 21 < size - i ? 21 : size - i) == 0;
    }
    n = packed ? 1032 * size : n;
    return 8 * n + 65536 + (packed ? 3 * n + 65536 : 0);
}

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
