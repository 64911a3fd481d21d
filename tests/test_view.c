/* test_view.c: examples/lib/pbw_view.h: what a page holds is the mesh and the arrays that were given; texts are
   escaped; full disks, memory that runs out, what is refused.  tests/view.sh looks at pages in a browser.  And
   pbw_film.h and pbw_generate.h: failures leave nothing. */
#define _GNU_SOURCE
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "../pbw.h"
#define PBW_IO_IMPLEMENTATION
#include "../examples/lib/pbw_io.h"
#define PBW_VIEW_IMPLEMENTATION
#include "../examples/lib/pbw_view.h"
#define PBW_FILM_IMPLEMENTATION
#include "../examples/lib/pbw_film.h"
#include "../examples/lib/pbw_generate.h"
#include "meter.h"
#include "test.h"
#include "watch.h"

static char folder[64], path[96];

/* The page, as text. */
static char *read_page(void)
{
    FILE *file = fopen(path, "rb");
    char *text = (char *)calloc(1, 1 << 22);
    size_t size = file == NULL || text == NULL ? 0 : fread(text, 1, (1 << 22) - 1, file);
    CHECK(size > 0);
    if (file != NULL) {
        fclose(file);
    }
    return text;
}

/* The bytes of the data block that begins behind mark, decoded; an independent base64. */
static unsigned char *block(const char *page, const char *mark, size_t *size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = strstr(page, mark), *end;
    unsigned char *out = (unsigned char *)calloc(1, 1 << 22);
    unsigned bits = 0;
    int count = 0;
    *size = 0;
    if (!CHECK(at != NULL && out != NULL)) {
        return out;
    }
    at = strchr(at, '\n');
    end = strstr(at, "</script>");
    for (; at < end; at++) {
        const char *digit = *at == '=' ? NULL : strchr(digits, *at);
        if (digit != NULL) {
            bits = bits << 6 | (unsigned)(digit - digits);
            if (++count % 4 != 1) {
                out[(*size)++] = (unsigned char)(bits >> (6 - 2 * ((count + 3) % 4)));
            }
        } else {
            CHECK(*at == '=' || *at == '\n');
        }
    }
    return out;
}

static float float_at(const unsigned char *bytes, size_t i)
{
    uint32_t bits = 0;
    float x;
    int k;
    for (k = 3; k >= 0; k--) {
        bits = bits << 8 | bytes[4 * i + (size_t)k];
    }
    memcpy(&x, &bits, 4);
    return x;
}

static uint64_t whole_at(const unsigned char *bytes, size_t *at)
{
    uint64_t x = 0;
    int shift = 0;
    do {
        x |= (uint64_t)(bytes[*at] & 127) << shift;
        shift += 7;
    } while (bytes[(*at)++] & 128);
    return x;
}

static void random_mesh(int dim, size_t count, double scale, pbw_mesh *mesh)
{
    double points[3 * 500];
    uint64_t state = 7;
    size_t i;
    for (i = 0; i < count * (size_t)dim; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        points[i] = ((double)(state >> 11) / 4503599627370496.0 - 1) * scale;
    }
    CHECK(pbw_triangulate(dim, points, NULL, count, NULL, mesh) == PBW_OK);
}

/* Writes a page of a mesh, with every third simplex left out, and reads all of it back. */
static void test_content(int dim, double scale)
{
    pbw_mesh mesh;
    pbwview_options options;
    pbwview_array arrays[4];
    pbwio_error error;
    static unsigned char keep[5000];
    static uint32_t whole[5000];
    static double real[5000], heights[500];
    pbw_index met[500];
    char *page;
    unsigned char *corners, *points, *lens, *of_simplices, *of_points;
    size_t size, at = 0, i, next = 0, n = (size_t)dim + 1, row = 0, at_whole = 0;
    double frame[4];
    uint32_t last = 0;
    memset(&mesh, 0, sizeof mesh);
    memset(&options, 0, sizeof options);
    memset(arrays, 0, sizeof arrays);
    random_mesh(dim, 500, scale, &mesh);
    for (i = 0; i < 5000; i++) {
        keep[i] = i % 3 != 0;
        whole[i] = i % 7 == 0 ? 0xffffffffu : (uint32_t)(i * 2654435761u) >> i % 32;
        real[i] = i % 11 == 0 ? HUGE_VAL : i % 13 == 0 ? 1e300 : sin((double)i);
        heights[i % 500] = scale * cos((double)i);
    }
    arrays[0].name = "rounds";
    arrays[0].whole = whole;
    arrays[1].name = "</script><b>'\"&";
    arrays[1].real = real;
    arrays[1].of_points = 1;
    options.arrays = arrays;
    options.array_count = 2;
    options.keep = keep;
    options.heights = dim == 2 ? heights : NULL;
    options.title = "</title><script>alert(1)</script>'\"&";
    options.note = "'><script>";
    options.colour = "rounds";
    CHECK(pbwview_write(path, &mesh, &options, &error) == PBWIO_OK);
    page = read_page();
    lens = block(page, "id='lens'>", &size);
    CHECK_EQUAL(size, 14 * 8);
    memcpy(frame, lens, sizeof frame);               /* as on all machines that have run this: little-endian */
    corners = block(page, "id='corners'>", &size);
    points = block(page, "id='points'>", &size);
    of_simplices = block(page, "data-name='rounds'", &i);
    of_points = block(page, "data-name='&#60;/script&#62;&#60;b&#62;&#39;&#34;&#38;'", &i);
    CHECK_EQUAL(i * 3, size);                                        /* one float a point, and three */
    for (i = 0; i < mesh.simplex_count; i++) {
        size_t k, j;
        uint64_t step;
        for (k = 0; keep[i] && k < n; k++) {
            size_t d = (size_t)whole_at(corners, &at), number = next - d, p = mesh.simplices[n * i + k];
            if (d == 0) {
                met[next++] = (pbw_index)p;
                for (j = 0; j < 3; j++) {
                    double x = j < (size_t)dim ? mesh.points[p * (size_t)dim + j] : heights[p];
                    double read = (double)float_at(points, row++);
                    CHECK(fabs(read - (x - frame[j]) / frame[3]) <= 6e-8 && fabs(read) <= 1.001);
                }
                CHECK(p % 11 == 0 ? isnan(float_at(of_points, number)) != 0
                      : p % 13 == 0 ? (double)float_at(of_points, number) > 3e38
                      : fabs((double)float_at(of_points, number) - real[p]) < 1e-7);
            }
            CHECK(number < next && met[number] == p);
        }
        if (keep[i]) {
            step = whole_at(of_simplices, &at_whole);
            last = step % 2 != 0 ? last - (uint32_t)((step + 1) / 2) : last + (uint32_t)(step / 2);
            CHECK_EQUAL(last, whole[i]);
        }
    }
    CHECK(strstr(page, "<title>&#60;/title&#62;&#60;script&#62;alert(1)&#60;/script&#62;&#39;&#34;&#38;</title>")
          != NULL && strstr(page, "data-note='&#39;&#62;&#60;script&#62;'") != NULL);
    CHECK(strcmp(page + strlen(page) - 8, "</html>\n") == 0);
    free(page);
    free(lens);
    free(corners);
    free(points);
    free(of_simplices);
    free(of_points);
    unlink(path);
    pbw_free(&mesh);
}

/* The faces of a model, the ids of points and which simplices are inside; a face that has no point is refused. */
static void test_model(void)
{
    static pbw_index faces[6] = { 7, 2, 7, 1, 40, 3 };
    pbw_mesh mesh;
    pbwview_options options;
    pbwio_error error;
    static unsigned char inside[2000];
    uint64_t ids[100], last = 0, step;
    unsigned char *read;
    size_t size, at = 0, i, run = 0;
    char *page;
    memset(&mesh, 0, sizeof mesh);
    memset(&options, 0, sizeof options);
    random_mesh(3, 50, 1, &mesh);
    for (i = 0; i < mesh.simplex_count; i++) {
        inside[i] = i % 5 < 2;
    }
    options.triangles = faces;
    options.triangle_count = 2;
    options.inside = inside;
    CHECK(pbwview_write(path, &mesh, &options, &error) == PBWIO_OK);
    page = read_page();
    read = block(page, "id='ids'>", &size);
    for (i = 0; i < 50; i++) {
        step = whole_at(read, &at);
        last = step % 2 != 0 ? last - (step + 1) / 2 : last + step / 2;
        ids[i] = last;
    }
    CHECK_EQUAL(at, size);
    free(read);
    read = block(page, "id='triangles'>", &size);
    for (i = 0, at = 0, last = 0; i < 6; i++) {
        step = whole_at(read, &at);
        last = step % 2 != 0 ? last - (step + 1) / 2 : last + step / 2;
        CHECK(last < 50 && ids[last] == faces[i]);
    }
    CHECK_EQUAL(at, size);
    free(read);
    read = block(page, "id='inside'>", &size);
    CHECK_EQUAL(whole_at(read, (at = 0, &at)), 0);                   /* the first run is of zeros: none */
    for (run = 0; at < size && run < 8; run++) {
        CHECK_EQUAL(whole_at(read, &at), run % 2 == 0 ? 2 : 3);
    }
    free(read);
    free(page);
    faces[3] = 50;
    CHECK(pbwview_write(path, &mesh, &options, &error) == PBWIO_ERROR_ARGUMENT);
    CHECK(strstr(error.text, "a corner that is no point") != NULL);
    unlink(path);
    pbw_free(&mesh);
}

static void test_points_only(void)
{
    static const double points[6] = { 5, 1, 5, 1, 5, 1 };            /* all at one place */
    pbw_mesh mesh;
    char *page;
    unsigned char *read;
    size_t size;
    memset(&mesh, 0, sizeof mesh);
    mesh.dim = 2;
    mesh.points = points;
    mesh.point_count = 3;
    CHECK(pbwview_write(path, &mesh, NULL, NULL) == PBWIO_OK);
    page = read_page();
    read = block(page, "id='points'>", &size);
    CHECK_EQUAL(size, 24);
    CHECK(float_at(read, 0) == 0 && float_at(read, 5) == 0 && strstr(page, "id='corners'>") == NULL);
    CHECK(strstr(page, "<title>pbw</title>") != NULL && strstr(page, "data-points='3' data-simplices='0'") != NULL);
    free(page);
    free(read);
    unlink(path);
}

/* A file-size limit stands for a full disk: the old file stays, and nothing else. */
static void test_errors(void)
{
    static unsigned char none[5000];
    pbw_mesh mesh;
    pbw_options build;
    pbwview_options options;
    pbwio_error error;
    struct rlimit old, small;
    char part[128];
    FILE *file = fopen(path, "w");
    memset(&mesh, 0, sizeof mesh);
    memset(&options, 0, sizeof options);
    random_mesh(3, 300, 1, &mesh);
    snprintf(part, sizeof part, "%s.part.%lu-0", path, (unsigned long)getpid());
    CHECK(file != NULL && fputs("old", file) >= 0 && fclose(file) == 0);
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old);
    small = old;
    for (small.rlim_cur = 1; small.rlim_cur < 40000; small.rlim_cur *= 6) {
        pbwio_status status;
        setrlimit(RLIMIT_FSIZE, &small);
        status = pbwview_write(path, &mesh, NULL, &error);
        setrlimit(RLIMIT_FSIZE, &old);
        CHECK(status == PBWIO_ERROR_FILE && strstr(error.text, "File too large") != NULL);
        CHECK(access(part, F_OK) != 0);
        file = fopen(path, "r");
        CHECK(file != NULL && getc(file) == 'o' && getc(file) == 'l' && getc(file) == 'd' && getc(file) == EOF);
        if (file != NULL) {
            fclose(file);
        }
    }
    if (access("/dev/full", W_OK) == 0) {
        CHECK(pbwview_write("/dev/full", &mesh, NULL, &error) == PBWIO_ERROR_FILE);
        CHECK(strcmp(error.text, "/dev/full: No space left on device") == 0);
    }
    CHECK(pbwview_write("/no/such/a.html", &mesh, NULL, &error) == PBWIO_ERROR_FILE);
    CHECK(strcmp(error.text, "/no/such/a.html: No such file or directory") == 0);
    memset(&build, 0, sizeof build);
    build.memory_limit = 100;
    options.build = &build;
    CHECK(pbwview_write(path, &mesh, &options, &error) == PBWIO_ERROR_MEMORY);
    CHECK(strstr(error.text, ": out of memory") != NULL);
    options.build = NULL;
    options.keep = none;
    CHECK(pbwview_write(path, &mesh, &options, &error) == PBWIO_OK);         /* no simplex is left: the points */
    pbw_free(&mesh);
    mesh.dim = 3;
    CHECK(pbwview_write(path, &mesh, NULL, &error) == PBWIO_ERROR_ARGUMENT);
    CHECK(strstr(error.text, ": there is nothing to show") != NULL);
    mesh.point_count = PBWVIEW_MOST + 1;
    CHECK(pbwview_write(path, &mesh, NULL, NULL) == PBWIO_ERROR_ARGUMENT);
    CHECK(pbwview_write(NULL, &mesh, NULL, &error) == PBWIO_ERROR_ARGUMENT);
    CHECK(pbwview_write(path, NULL, NULL, &error) == PBWIO_ERROR_ARGUMENT);
    mesh.simplex_count = 1;
    for (mesh.dim = -1; mesh.dim < 5; mesh.dim += mesh.dim == 1 ? 3 : 1) {
        CHECK(pbwview_write(path, &mesh, NULL, &error) == PBWIO_ERROR_ARGUMENT);
    }
    unlink(path);
}

enum { FRAMES = 5 };

typedef struct frames { int made, fails_at; } frames;

static int next_frame(void *user, pbwfilm_frame *frame)
{
    static const double corner[6] = { 0, 0, 1, 0, 0, 1 };
    frames *f = (frames *)user;
    frame->count = 1;
    frame->corners = 3;
    frame->points = corner;
    return f->made == f->fails_at ? -1 : f->made++ < FRAMES;
}

/* Writes the film; after a failure there must be neither a file nor memory that is held. */
static pbwio_status film(const pbwfilm_options *options, int fails_at, meter *m)
{
    frames f = { 0, fails_at };
    pbwio_error error = { "" };
    pbwio_status status;
    status = pbwfilm_write(path, options, next_frame, &f, &error);
    CHECK((status == PBWIO_OK) == (access(path, F_OK) == 0) && (status == PBWIO_OK) == (error.text[0] == 0));
    CHECK(status != PBWIO_OK || f.made == FRAMES + 1);
    CHECK(m == NULL || (m->blocks == 0 && m->faults == 0));
    remove(path);
    return status;
}

static void test_film(void)
{
    pbwfilm_options options = { 0 };
    pbw_options build = { 0 };
    pbwio_status status;
    meter m;
    watch w;
    long k;
    options.box[2] = options.box[3] = options.range[1] = 1;
    CHECK_EQUAL(film(&options, -1, NULL), PBWIO_OK);
    CHECK_EQUAL(film(&options, 0, NULL), PBWIO_CANCELLED);
    CHECK_EQUAL(film(&options, 3, NULL), PBWIO_CANCELLED);
    options.build = &build;
    options.frames = FRAMES;
    build.progress = watch_progress;
    build.progress_user = &w;
    for (k = 1; k <= FRAMES + 1; k++) {
        watch_start(&w, k);
        CHECK_EQUAL(film(&options, -1, NULL), PBWIO_CANCELLED);
    }
    watch_start(&w, 0);
    CHECK_EQUAL(film(&options, -1, NULL), PBWIO_OK);
    CHECK(w.calls == FRAMES + 1 && w.wrong == 0);
    build.resize = meter_resize;
    build.resize_user = &m;
    for (k = 1, status = PBWIO_OK; k == 1 || m.refused > 0; k++) {
        watch_start(&w, 0);
        meter_start(&m, k, 0);
        status = film(&options, -1, &m);
        CHECK_EQUAL(status, m.refused > 0 ? PBWIO_ERROR_MEMORY : PBWIO_OK);
    }
    CHECK(k > 2);
    build.memory_limit = 1;
    CHECK_EQUAL(film(&options, -1, &m), PBWIO_ERROR_MEMORY);
}

static void test_generate(void)
{
    enum { MOST = 40000 };
    pbw_options options = { 0 };
    pbwio_cloud cloud, other;
    meter m;
    watch w;
    long k;
    int kind;
    CHECK_EQUAL(pbwgen_points(-1, 3, 5, 1, NULL, &cloud), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwgen_points(11, 3, 5, 1, NULL, &cloud), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwgen_points(0, 4, 5, 1, NULL, &cloud), PBW_ERROR_ARGUMENT);
    CHECK_EQUAL(pbwgen_points(0, 3, (size_t)-1 / 16, 1, NULL, &cloud), PBW_ERROR_MEMORY);
    options.resize = meter_resize;
    options.resize_user = &m;
    for (kind = 0; kind < 11; kind++) {
        meter_start(&m, 0, 0);
        CHECK_EQUAL(pbwgen_points(kind, 2, 100, 7, &options, &cloud), PBW_OK);
        CHECK_EQUAL(pbwgen_points(kind, 2, 100, 7, NULL, &other), PBW_OK);
        CHECK(cloud.count == 100 && memcmp(cloud.points, other.points, 1600) == 0);
        pbwio_free(&cloud);
        pbwio_free(&other);
        CHECK(m.blocks == 0 && m.faults == 0 && m.requests == 1);
        meter_start(&m, 1, 0);
        CHECK_EQUAL(pbwgen_points(kind, 2, 100, 7, &options, &cloud), PBW_ERROR_MEMORY);
        CHECK(cloud.count == 0 && cloud.points == NULL && m.blocks == 0);
        pbwio_free(&cloud);
    }
    options.progress = watch_progress;
    options.progress_user = &w;
    options.memory_limit = 100 + MOST * 16;
    for (k = 0; k < 4; k++) {
        meter_start(&m, 0, 0);
        watch_start(&w, k);
        CHECK_EQUAL(pbwgen_points(0, 2, MOST, 7, &options, &cloud), k > 0 ? PBW_CANCELLED : PBW_OK);
        CHECK(w.calls == (k > 0 ? k : 3) && w.wrong == 0);
        pbwio_free(&cloud);
        CHECK(m.blocks == 0 && m.faults == 0);
    }
    CHECK_EQUAL(pbwgen_points(0, 2, MOST + 10, 7, &options, &cloud), PBW_ERROR_MEMORY);
    pbwio_free(&cloud);
}

int main(int argc, char **argv)
{
    static const double scales[] = { 1, 1.7e308, 1e-300, 5e-320 };
    int dim, i;
    test_start(argc, argv, 0);
    strcpy(folder, "/tmp/pbw-test-XXXXXX");
    if (mkdtemp(folder) == NULL) {
        return 1;
    }
    snprintf(path, sizeof path, "%s/a.html", folder);
    for (dim = 2; dim <= 3; dim++) {
        for (i = 0; i < 4; i++) {
            if (test_begin("a page holds the mesh, %dD, coordinates up to %g", dim, scales[i])) {
                test_content(dim, scales[i]);
                test_end();
            }
        }
    }
    if (test_begin("a page of a model")) {
        test_model();
        test_end();
    }
    if (test_begin("a page of points")) {
        test_points_only();
        test_end();
    }
    if (test_begin("what cannot be written")) {
        test_errors();
        test_end();
    }
    if (test_begin("films: memory that runs out, frames that fail, progress that says stop")) {
        test_film();
        test_end();
    }
    if (test_begin("generated points: memory that runs out, progress that says stop")) {
        test_generate();
        test_end();
    }
    rmdir(folder);
    return test_finish();
}
