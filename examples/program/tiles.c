/* tiles.c: pbw tiles: triangulates points that memory does not hold, tile by tile, into a .pbwt file.

   Beside the output is a folder of scratch files:

     state       replaced as a whole after each step, so that a run that was killed or found the disk full goes on;
                 with the sums of all files but trees, and its own
     lock        locked by the run that works there
     N.points    the points of tile N, in the order of the input
     N.tree      those points, sorted, with boxes, then sums of its blocks
     N.facets    the facets of tile N to link
     N.border    simplices with a corner that may be given up

   Where no run could go on, as after bad input, all of them are removed. */
#include "program.h"
#include "pbw_tilefile.h"
#include <errno.h>
#include <sys/stat.h>
#include <sys/types.h>
#ifdef _WIN32
#include <io.h>
#else
#include <pthread.h>
#include <unistd.h>
extern int truncate(const char *path, off_t length);         /* strict C modes hide it */
#endif

enum { MOST_TILES = 65536 };

static const option tiles_options[] = {
    { "--tiles", "N", "how many; default: as --memory-limit (default 4G) needs", WHOLE, 1, MOST_TILES, NULL },
    { "--no-links", NULL, "simplices only: half the file", SWITCH, 0, 0, NULL },
    { "--no-mesh", NULL, "no file at all: only the counts and the hash", SWITCH, 0, 0, NULL },
    { "--scratch", "DIR", "folder of scratch files; default: the output's name, or the input's, with .scratch", PLAIN,
      0, 0, NULL },
    { "--halo", "H", "width of the first halo in spacings; default 1.5", POSITIVE, 0, 0, NULL },
    { "--work", "N", "on surfaces, where tiles ask each other about everything: how long they try, in visits a\n"
      "point; default 20.  What is left then is triangulated at once", WHOLE, 1, 1e9, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

enum { NAME = 1200, SAMPLES = 65536, BUFFER = 4096, AT_A_TIME = 4 };
#define BUFFERS 268435456.0                          /* bytes of all buffers of points on their way to their tiles */

typedef struct tile_state {
    uint64_t given, facets, border, hull, halo, later, rounds, questions, simplices;
    uint64_t points;                                 /* in N.points */
    uint64_t points_sum, head_sum, facets_sum, border_sum;   /* of records, of the chunk's head, of files */
    pbw_hash_sums hash;
    pbwtf_entry entry;
} tile_state;

typedef struct state {
    char magic[8];                                   /* "PBWSTAT5" */
    uint32_t dim, weighted, links, parts, mesh, unused;
    uint64_t points, input_mark;                     /* input_mark: differs for another input, see mark_of_input */
    uint32_t distributed, trees, done, chunks;       /* steps that are finished; tiles done, in their order */
    uint64_t size, number;                           /* of the output so far; its file's number */
    char out[1100];                                  /* the output while it grows */
} state;

typedef struct tree_head { pbwt_summary summary; uint64_t duplicates; } tree_head;

typedef struct work {
    job *j;
    state s;
    tile_state *tile;                                /* parts + 1 */
    char scratch[1024];
    int lock;                                        /* the file, or -1 */
    FILE *input;                                     /* .bin; else the points are in the cloud */
    pbwtf_map *map;                                  /* of trees, and sums of their blocks */
    uint64_t **sums;
    size_t bad;                                      /* 1 + the tile of which the tree cannot be read */
    pbwt_tree *tree;
    pbwt_summary *summary;
    pbwt_options options;                            /* build: with all memory and threads */
    pbwt_limits limits;
    int jobs;                                        /* tiles at a time */
    int hopeless;                                    /* it failed, and the same would again whatever was finished */
    double start;
} work;

static const char *name_of(const work *w, const char *what, size_t tile, char *name)
{
    snprintf(name, NAME, "%s/%lu.%s", w->scratch, (unsigned long)tile, what);
    return name;
}

static int cannot(const work *w, const char *path)
{
    return fail(w->j, "%s: %s; what is finished stays, and the same command goes on from there", path,
                errno != 0 ? strerror(errno) : "cannot read or write it");
}

/* A scratch file is not what was written. */
static int bad_scratch(work *w, const char *name, const char *what)
{
    w->hopeless = 1;
    return fail(w->j, "%s: %s: scratch files are removed, start again", name,
                what != NULL ? what : "missing, truncated or damaged");
}

static int paused(work *w)
{
    w->hopeless |= !w->s.distributed;
    return w->s.distributed
         ? fail(w->j, "interrupted; %u of %zu tile%s %s finished and kept in %s: the same command goes on from there",
                w->s.done, COUNT(w->s.parts), w->s.parts == 1 ? "is" : "are", w->scratch)
         : fail(w->j, "interrupted; nothing was finished");
}

/* ---- the folder of scratch files: one run at a time ---- */

/* A folder that is there, and no scratch folder, must not have files with the names of scratch files. */
static int is_clear(const work *w)
{
    static const char *const kinds[] = { "points", "tree", "facets", "border" };
    char name[NAME];
    struct stat there;
    size_t p, k;
    snprintf(name, sizeof name, "%s/state", w->scratch);
    if (stat(name, &there) == 0) {
        return 0;
    }
    for (p = 0; p <= w->s.parts; p++) {
        for (k = 0; k < 4; k++) {
            if (stat(name_of(w, kinds[k], p, name), &there) == 0) {
                return 0;
            }
        }
    }
    return 1;
}

static int take_scratch(work *w)
{
    char error[PBWTF_ERROR];
    int is_foreign;
    if (pbwtf_enter(w->scratch, &w->lock, &is_foreign, error) != PBW_OK) {
        return fail(w->j, "%s", error);
    }
    if (is_foreign && !is_clear(w)) {
        pbwtf_leave(w->scratch, w->lock, 1);
        w->lock = -1;
        return fail(w->j, "%s has files of other programs with names of scratch files: name another --scratch",
                    w->scratch);
    }
    return 0;
}

/* ---- the state ---- */

static int save_state(const work *w)
{
    const size_t tiles = w->s.parts + (size_t)1;
    const uint64_t sum = pbwtf_sum(&w->s, sizeof w->s), tile_sum = pbwtf_sum(w->tile, tiles * sizeof *w->tile);
    char name[NAME], part[NAME];
    FILE *file;
    int good;
    snprintf(name, sizeof name, "%s/state", w->scratch);
    snprintf(part, sizeof part, "%s/state.part", w->scratch);
    errno = 0;
    file = fopen(part, "wb");
    good = file != NULL && fwrite(&w->s, sizeof w->s, 1, file) == 1 && fwrite(&sum, sizeof sum, 1, file) == 1
        && fwrite(w->tile, sizeof *w->tile, tiles, file) == tiles && fwrite(&tile_sum, sizeof tile_sum, 1, file) == 1;
    good = (file == NULL || fclose(file) == 0) && good;
    return good && rename(part, name) == 0 ? 0 : cannot(w, name);
}

static void remove_scratch(const work *w, size_t parts)
{
    static const char *const kinds[] = { "points", "tree", "tree.part", "facets", "border" };
    char name[NAME];
    size_t p, k;
    for (p = 0; p <= parts; p++) {
        for (k = 0; k < 5; k++) {
            remove(name_of(w, kinds[k], p, name));
        }
    }
}

/* A checksum of all points in memory; of a file its time of change, and 1024 of its records. */
static uint64_t mark_of_input(const work *w)
{
    const size_t dim = w->s.dim, record = (dim + w->s.weighted) * sizeof(double);
    uint64_t mark = 0, i;
    struct stat about;
    double row[4];
    if (w->input == NULL) {
        mark = pbwtf_checksum(mark, w->j->cloud.points, w->s.points * dim * sizeof(double));
        return w->s.weighted ? pbwtf_checksum(mark, w->j->cloud.weights, w->s.points * sizeof(double)) : mark;
    }
    if (stat(w->j->input, &about) == 0) {
        mark = (uint64_t)about.st_mtime;
    }
    for (i = 0; i < 1024; i++) {
        const uint64_t at = w->s.points / 1024 * i + w->s.points % 1024 * i / 1024;
        if (pbwtf_seek(w->input, at * record) && fread(row, record, 1, w->input) == 1) {
            mark = pbwtf_checksum(mark, row, record);
        }
    }
    return mark;
}

/* A finished chunk of the output that is not complete yet: its head, and what comes after its simplices. */
static int view_chunk(const work *w, const pbwtf_map *chunks, size_t p, pbwtf_view *view)
{
    char error[PBWTF_ERROR];
    pbwtf_header header;
    memset(&header, 0, sizeof header);
    header.dim = w->s.dim;
    header.flags = (w->s.weighted ? PBWTF_WEIGHTS : 0) | (w->s.links ? PBWTF_LINKS : 0);
    header.tiles = w->s.parts;
    if (pbwtf_view_at(chunks, &header, &w->tile[p].entry, p, view, error) != PBW_OK) {
        return 0;
    }
    pbwtf_fetch(chunks, view->foreign, (size_t)((const char *)view->across - (const char *)view->foreign));
    return pbwtf_fault(chunks) == NULL;
}

/* Whether a scratch file has so many bytes with that sum. */
static int is_intact(const char *name, uint64_t size, uint64_t sum)
{
    char error[PBWTF_ERROR];
    pbwtf_map map;
    int good = pbwtf_map_file(name, NULL, &map, error) == PBW_OK;
    if (good) {
        good = map.size == size && pbwtf_sum(pbwtf_fetch(&map, map.data, map.size), map.size) == sum
            && pbwtf_fault(&map) == NULL;
        pbwtf_unmap(&map);
    }
    return good;
}

/* Whether the chunk of a finished tile is in the output, and its scratch files are as they were written. */
static int is_tile_intact(const work *w, const pbwtf_map *chunks, size_t p)
{
    const tile_state *t = w->tile + p;
    char name[NAME];
    pbwtf_view view;
    if (w->s.mesh) {
        if (!view_chunk(w, chunks, p, &view) || pbwtf_sum(view.chunk, sizeof *view.chunk) != t->head_sum) {
            return 0;
        }
        pbwtf_fetch(chunks, view.chunk, view.size);
        if (pbwtf_checksum(0, view.own, pbwtf_across_offset(view.chunk) - sizeof *view.chunk) != view.chunk->checksum
            || pbwtf_fault(chunks) != NULL) {
            return 0;
        }
    }
    return is_intact(name_of(w, "facets", p, name), t->facets * sizeof(pbwt_facet), t->facets_sum)
        && is_intact(name_of(w, "border", p, name), t->border * sizeof(uint32_t), t->border_sum);
}

/* Finished tiles that are damaged, and those after the first of them, are made again. */
static void check_finished(work *w)
{
    char error[PBWTF_ERROR];
    pbwtf_map chunks = { NULL, 0, NULL };
    uint32_t p = 0;
    if (pbwtf_map_file(w->s.out, NULL, &chunks, error) == PBW_OK) {
        while (p < w->s.chunks && is_tile_intact(w, &chunks, p)) {
            pbwtf_forget(&chunks);
            p++;
        }
        pbwtf_unmap(&chunks);
    }
    if (p < w->s.chunks) {
        warn(w->j, "what an earlier run finished is damaged: tiles are made again from number %u on", p);
        w->s.size = w->tile[p].entry.offset;
        w->s.done = w->s.chunks = p;
    }
}

/* Whether the state of an earlier run is whole, and of the same input and options. */
static int read_state(const work *w, FILE *file, const state *s)
{
    const size_t tiles = s->parts + (size_t)1;
    uint64_t sum = 0;
    return s->dim == w->s.dim && s->weighted == w->s.weighted && s->links == w->s.links && s->mesh == w->s.mesh
        && s->parts == w->s.parts && s->points == w->s.points && s->input_mark == w->s.input_mark
        && fread(w->tile, sizeof *w->tile, tiles, file) == tiles && fread(&sum, sizeof sum, 1, file) == 1
        && sum == pbwtf_sum(w->tile, tiles * sizeof *w->tile);
}

/* Takes up what an earlier run left, if its output is there; else removes it. */
static void load_state(work *w)
{
    char name[NAME];
    struct stat output;
    state s;
    uint64_t sum;
    FILE *file;
    int is_state, is_there;
    memset(&s, 0, sizeof s);
    snprintf(name, sizeof name, "%s/state", w->scratch);
    file = fopen(name, "rb");
    is_state = file != NULL && fread(&s, sizeof s, 1, file) == 1 && fread(&sum, sizeof sum, 1, file) == 1
            && memcmp(s.magic, w->s.magic, 8) == 0 && pbwtf_sum(&s, sizeof s) == sum;
    is_there = is_state && s.size > 0 && stat(s.out, &output) == 0 && (uint64_t)output.st_ino == s.number;
    if (is_state && (s.size == 0 || is_there) && read_state(w, file, &s)) {
        w->s = s;
        begin(w->j, "tiles", "those of an earlier run are read");
        check_finished(w);
        report_line(w->j, "going on: %u of %zu tile%s %s finished", w->s.done, COUNT(s.parts),
                    s.parts == 1 ? "is" : "are");
    } else {
        memset(w->tile, 0, (w->s.parts + 1) * sizeof *w->tile);
        remove_scratch(w, is_state && s.parts > w->s.parts ? s.parts : w->s.parts);
        if (is_there) {
            remove(s.out);
        }
    }
    if (file != NULL) {
        fclose(file);
    }
}

/* ---- input ---- */

static int open_input(work *w)
{
    job *j = w->j;
    const char *dot = j->input != NULL ? strrchr(j->input, '.') : NULL;
    uint64_t record;
    int64_t size;
    if (dot == NULL || strcmp(dot, ".bin") != 0) {
        const int failed = load(j, 1);
        w->s.dim = (uint32_t)j->cloud.dim;
        w->s.weighted = j->cloud.weights != NULL;
        w->s.points = j->cloud.count;
        return failed;
    }
    w->s.dim = j->read.dim == 2 ? 2 : 3;
    w->s.weighted = j->read.weight != NULL;
    record = (w->s.dim + w->s.weighted) * sizeof(double);
    errno = 0;
    w->input = fopen(j->input, "rb");
    size = w->input != NULL && fseek(w->input, 0, SEEK_END) == 0 ? pbwtf_tell(w->input) : -1;
    if (size < 0) {
        return fail(j, "%s: %s", j->input, strerror(errno));
    }
    if ((uint64_t)size % record != 0) {
        return fail(j, "%s: truncated: its size, %ld, is no multiple of %lu, that of a record", j->input,
                    (long)size, (unsigned long)record);
    }
    w->s.points = (uint64_t)size / record;
    report_line(j, "%zu point%s in %uD%s", COUNT(w->s.points), w->s.dim, w->s.weighted ? ", weighted" : "");
    return 0;
}

/* Reads points from..from+count-1, from the position of `file` on.  Returns how many are there and finite, up to the
   first that is not. */
static size_t read_points(const work *w, FILE *file, uint64_t from, size_t count, pbwt_point *out)
{
    const size_t dim = w->s.dim, each = dim + w->s.weighted;
    char *rows = (char *)(out + count) - count * each * sizeof(double);  /* at the end: points do not catch up */
    double row[4];
    size_t i;
    count = file != NULL ? fread(rows, each * sizeof *row, count, file) : count;
    for (i = 0; i < count; i++) {
        if (file != NULL) {
            memcpy(row, rows + i * each * sizeof *row, each * sizeof *row);
        } else {
            memcpy(row, w->j->cloud.points + (from + i) * dim, dim * sizeof *row);
            row[dim] = w->s.weighted ? w->j->cloud.weights[from + i] : 0;
        }
        out[i].x[2] = 0;
        memcpy(out[i].x, row, dim * sizeof *row);
        out[i].weight = w->s.weighted ? row[dim] : 0;
        out[i].id = from + i;
        if (!(fabs(row[0]) <= DBL_MAX && fabs(row[1]) <= DBL_MAX && fabs(out[i].x[2]) <= DBL_MAX
              && fabs(out[i].weight) <= DBL_MAX)) {
            break;
        }
    }
    return i;
}

static int bad_point(work *w, FILE *file, uint64_t at)
{
    w->hopeless = 1;
    return file != NULL && (feof(file) || ferror(file))
         ? fail(w->j, "%s: truncated: point %.0f cannot be read", w->j->input, (double)at)
         : fail(w->j, "point %.0f: a number is not finite", (double)at);
}

/* ---- threads at work: readers of the input, then builders of tiles ---- */

typedef struct workers {
    work *w;
    FILE *out;
    size_t next;                                     /* the tile to begin */
    uint64_t read;                                   /* points that are distributed */
    unsigned char *started;                          /* per tile: its file is there */
    unsigned char *at_work;                          /* per tile: its tree is in memory */
    int reading, forgetting;                         /* workers that read trees; one waits for them */
    int stop, failed, short_of_memory;
#ifndef _WIN32
    pthread_mutex_t lock;                            /* for all workers, the report and work.s.done */
    pthread_cond_t turn;
#endif
} workers;

#ifdef _WIN32                                        /* one at a time */
enum { READERS = 1 };
static void workers_start(workers *c) { (void)c; }
static void workers_end(workers *c) { (void)c; }
static void enter(workers *c) { (void)c; }
static void leave(workers *c) { (void)c; }
static void await(workers *c) { c->stop = 1; }
static void wake(workers *c) { (void)c; }
#else
enum { READERS = 256 };
static void workers_start(workers *c)
{
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->turn, NULL);
}

static void workers_end(workers *c)
{
    pthread_cond_destroy(&c->turn);
    pthread_mutex_destroy(&c->lock);
}

static void enter(workers *c) { pthread_mutex_lock(&c->lock); }
static void leave(workers *c) { pthread_mutex_unlock(&c->lock); }
static void await(workers *c) { pthread_cond_wait(&c->turn, &c->lock); }
static void wake(workers *c) { pthread_cond_broadcast(&c->turn); }
#endif

/* ---- distribution ---- */

static int make_cuts(work *w, pbwt_cut *cuts)
{
    const size_t count = w->s.points < SAMPLES ? (size_t)w->s.points : SAMPLES;
    const uint64_t record = (w->s.dim + w->s.weighted) * sizeof(double);
    pbwt_point *sample = (pbwt_point *)malloc((count + 1) * sizeof *sample);
    uint64_t random = 12345;
    size_t i;
    int failed = sample == NULL ? fail(w->j, "out of memory") : 0;
    for (i = 0; i < count && !failed; i++) {         /* one of each of `count` runs of points */
        const uint64_t from = w->s.points * i / count, to = w->s.points * (i + 1) / count;
        const uint64_t at = from + (random >> 33) % (to - from);
        random = random * 6364136223846793005u + 1442695040888963407u;
        if (w->input != NULL && !pbwtf_seek(w->input, at * record)) {
            failed = cannot(w, w->j->input);
        }
        if (!failed && read_points(w, w->input, at, 1, sample + i) != 1) {
            failed = bad_point(w, w->input, at);
        }
    }
    if (!failed) {
        pbwt_cut_points((int)w->s.dim, sample, count, (int)w->s.parts, cuts);
    }
    free(sample);
    return failed;
}

/* Of records in any order. */
static uint64_t sum_of_points(const pbwt_point *points, size_t count)
{
    uint64_t sum = 0;
    size_t i;
    for (i = 0; i < count; i++) {
        sum += pbwtf_checksum(1, points + i, sizeof *points);
    }
    return sum;
}

static int flush_points(workers *c, size_t tile, const pbwt_point *points, size_t count)
{
    char name[NAME];
    FILE *file;
    int good;
    errno = 0;
    file = fopen(name_of(c->w, "points", tile, name), c->started[tile] ? "ab" : "wb");
    good = file != NULL && fwrite(points, sizeof *points, count, file) == count;
    good = (file == NULL || fclose(file) == 0) && good;
    c->started[tile] = 1;
    return good ? 0 : cannot(c->w, name);
}

typedef struct reading {
    workers c;
    const pbwt_cut *cuts;
    size_t readers, each;                            /* room of each for points: of each tile and of the input */
} reading;

/* Writes the points of a tile that a reader has, unless the workers stop. */
static void pass_on(workers *c, size_t tile, const pbwt_point *points, size_t count)
{
    const uint64_t sum = sum_of_points(points, count);
    enter(c);
    if (!c->stop) {
        c->w->tile[tile].points += count;
        c->w->tile[tile].points_sum += sum;
        c->failed = flush_points(c, tile, points, count);
        c->stop = c->failed;
    }
    leave(c);
}

/* Sorts points of the input, from the position of `file` on; used: points in the buffer of each tile. */
static void distribute_run(reading *r, FILE *file, uint64_t from, uint64_t to, pbwt_point *room, size_t *used)
{
    workers *c = &r->c;
    work *w = c->w;
    pbwt_point *block = room + w->s.parts * r->each;
    int stop = 0;
    size_t i, p;
    for (; from < to && !stop; from += r->each) {
        const size_t count = to - from < r->each ? (size_t)(to - from) : r->each;
        const size_t good = read_points(w, file, from, count, block);
        for (i = 0; i < good; i++) {
            p = (size_t)pbwt_part((int)w->s.dim, r->cuts, (int)w->s.parts, block + i);
            room[p * r->each + used[p]++] = block[i];
            if (used[p] == r->each) {
                pass_on(c, p, room + p * r->each, r->each);
                used[p] = 0;
            }
        }
        enter(c);
        c->read += count;
        if (good < count && !c->stop) {
            c->failed = bad_point(w, file, from + good);
        }
        c->stop |= c->failed || draw_bar(w->j, "order", (double)c->read / (double)w->s.points);
        stop = c->stop;
        leave(c);
    }
    for (p = 0; p < w->s.parts && !stop; p++) {
        pass_on(c, p, room + p * r->each, used[p]);
    }
}

/* The reader that starts at `from` of work.s.points * reader / readers. */
static pbw_status read_share(void *arg, size_t reader, size_t end)
{
    reading *r = (reading *)arg;
    const work *w = r->c.w;
    const uint64_t from = w->s.points * reader / r->readers, to = w->s.points * end / r->readers;
    const uint64_t record = (w->s.dim + w->s.weighted) * sizeof(double);
    pbwt_point *room = (pbwt_point *)malloc((w->s.parts + 1) * r->each * sizeof *room);
    size_t *used = (size_t *)calloc(w->s.parts, sizeof *used);
    FILE *file = w->input != NULL ? fopen(w->j->input, "rb") : NULL;
    const int good = w->input == NULL || (file != NULL && pbwtf_seek(file, from * record));
    if (room == NULL || used == NULL || !good) {
        enter(&r->c);
        if (!r->c.stop) {
            r->c.failed = room == NULL || used == NULL ? fail(w->j, "out of memory") : cannot(w, w->j->input);
        }
        r->c.stop = 1;
        leave(&r->c);
    } else {
        distribute_run(r, file, from, to, room, used);
    }
    if (file != NULL) {
        fclose(file);
    }
    free(room);
    free(used);
    return PBW_OK;
}

/* Sorts the input into a file a tile, by several readers. */
static int distribute(work *w)
{
    pbwt_cut *cuts = (pbwt_cut *)calloc(w->s.parts, sizeof *cuts);
    pbw_options options;
    reading r;
    int failed;
    memset(&options, 0, sizeof options);
    memset(&r, 0, sizeof r);
    r.c.w = w;
    r.cuts = cuts;
    r.c.started = (unsigned char *)calloc(w->s.parts, 1);
    failed = cuts == NULL || r.c.started == NULL ? fail(w->j, "out of memory") : make_cuts(w, cuts);
    if (!failed) {
        const double threads = fmin(fmin(w->options.build.threads, READERS), 1 + (double)w->s.points / 1000000);
        const double records = BUFFERS / sizeof(pbwt_point) / (w->s.parts + 1.0);
        r.readers = threads > 1 ? (size_t)threads : 1;
        r.each = (size_t)fmax(64, fmin(BUFFER, records / (double)r.readers));
        options.threads = (int)r.readers;
        workers_start(&r.c);
        pbw_for(&options, r.readers, 1, read_share, &r);
        workers_end(&r.c);
        failed = r.c.failed ? r.c.failed : r.c.stop ? paused(w) : 0;
    }
    free(cuts);
    free(r.c.started);
    w->s.distributed = !failed;
    return failed ? failed : save_state(w);
}

/* ---- trees ---- */

typedef struct tree_file { FILE *file; char *block; uint64_t *sums; size_t filled, blocks; int failed; } tree_file;

/* Bytes of a tree in its file, before the sums of blocks. */
static size_t tree_size(uint64_t points)
{
    return sizeof(tree_head) + (size_t)points * sizeof(pbwt_point) + pbwt_boxes_of((size_t)points) * sizeof(pbwt_box);
}

static size_t tree_blocks(uint64_t points)
{
    return (tree_size(points) + PBWTF_BLOCK - 1) / PBWTF_BLOCK;
}

static void end_block(tree_file *f)
{
    if (f->filled > 0) {
        f->sums[f->blocks++] = pbwtf_sum(f->block, f->filled);
        f->failed |= fwrite(f->block, 1, f->filled, f->file) != f->filled;
        f->filled = 0;
    }
}

static void put_bytes(tree_file *f, const void *data, size_t size)
{
    const char *from = (const char *)data;
    while (size > 0) {
        const size_t room = PBWTF_BLOCK - f->filled, some = size < room ? size : room;
        memcpy(f->block + f->filled, from, some);
        from += some;
        size -= some;
        f->filled += some;
        if (f->filled == PBWTF_BLOCK) {
            end_block(f);
        }
    }
}

static int write_tree(const work *w, const pbwt_tree *tree, const char *name)
{
    const size_t blocks = tree_blocks(tree->count);
    char part[NAME + 8];
    tree_head head;
    tree_file f;
    memset(&f, 0, sizeof f);
    memset(&head, 0, sizeof head);
    pbwt_summarise(tree, &head.summary);
    head.duplicates = tree->duplicates;
    snprintf(part, sizeof part, "%s.part", name);
    errno = 0;
    f.block = (char *)malloc(PBWTF_BLOCK);
    f.sums = (uint64_t *)calloc(blocks + 1, sizeof *f.sums);
    f.file = f.block != NULL && f.sums != NULL ? fopen(part, "wb") : NULL;
    if (f.file != NULL) {
        put_bytes(&f, &head, sizeof head);
        put_bytes(&f, tree->points, tree->count * sizeof *tree->points);
        put_bytes(&f, tree->boxes, tree->box_count * sizeof *tree->boxes);
        end_block(&f);
        f.sums[blocks] = pbwtf_sum(f.sums, blocks * sizeof *f.sums);
        f.failed |= fwrite(f.sums, sizeof *f.sums, blocks + 1, f.file) != blocks + 1;
    }
    f.failed |= f.file == NULL || fclose(f.file) != 0;
    free(f.block);
    free(f.sums);
    return !f.failed && rename(part, name) == 0 ? 0 : cannot(w, name);
}

/* Reads the sums of blocks at the end of a tree's file.  Returns NULL if the file is not whole. */
static uint64_t *read_sums(const work *w, const char *name, uint64_t *points)
{
    FILE *file = fopen(name, "rb");
    uint64_t *sums = NULL;
    tree_head head;
    size_t blocks = 0;
    int good = file != NULL && fread(&head, sizeof head, 1, file) == 1 && head.summary.count <= w->s.points;
    if (good) {
        *points = head.summary.count;
        blocks = tree_blocks(*points);
        sums = (uint64_t *)malloc((blocks + 1) * sizeof *sums);
        good = sums != NULL && pbwtf_seek(file, tree_size(*points))
            && fread(sums, sizeof *sums, blocks + 1, file) == blocks + 1 && getc(file) == EOF
            && pbwtf_sum(sums, blocks * sizeof *sums) == sums[blocks];
    }
    if (file != NULL) {
        fclose(file);
    }
    if (!good) {
        free(sums);
    }
    return good ? sums : NULL;
}

static void need_tree(void *user, const void *from, size_t size)
{
    pbwtf_fetch((const pbwtf_map *)user, from, size);
}

/* Maps the tree of a tile.  Returns 0 if the file is not what was written. */
static int open_tree(work *w, size_t p, const char *name)
{
    char error[PBWTF_ERROR];
    const pbwt_point *points;
    tree_head head;
    uint64_t count = 0;
    w->sums[p] = read_sums(w, name, &count);
    if (w->sums[p] == NULL || pbwtf_map_file(name, NULL, w->map + p, error) != PBW_OK) {
        return 0;
    }
    pbwtf_expect(w->map + p, tree_size(count), w->sums[p]);
    memcpy(&head, pbwtf_fetch(w->map + p, w->map[p].data, sizeof head), sizeof head);
    if (pbwtf_fault(w->map + p) != NULL || head.summary.count != count || w->map[p].size != tree_size(count)) {
        return 0;
    }
    w->summary[p] = head.summary;
    points = (const pbwt_point *)(const void *)(w->map[p].data + sizeof head);
    pbwt_tree_over((int)w->s.dim, (int)p, w->summary + p, points, (const pbwt_box *)(const void *)(points + count),
                   w->tree + p);
    w->tree[p].duplicates = (size_t)head.duplicates;
    w->tree[p].need = need_tree;
    w->tree[p].need_user = w->map + p;
    pbwtf_forget(w->map + p);
    return 1;
}

/* Of trees of which no tile at work is made, so much of the memory may stay. */
enum { SHARE_OF_TREES = 16 };

/* The options of one tile when `jobs` are at work: a share of the threads and of the memory that trees leave. */
static pbw_options share_of(const work *w, int jobs, size_t tree)
{
    pbw_options share = w->options.build;
    const size_t memory = share.memory_limit - share.memory_limit / SHARE_OF_TREES;
    share.threads = share.threads > jobs ? share.threads / jobs : 1;
    share.memory_limit = memory / (size_t)jobs > tree ? memory / (size_t)jobs - tree : 1;
    return share;
}

static int is_interrupted(void *user, pbw_stage stage, double done)
{
    (void)user;
    (void)stage;
    (void)done;
    return interrupted;
}

/* Would another limit of memory make other tiles, for which nothing that is finished is of use? */
static int is_bound_to_limit(const work *w)
{
    return !is_given(w->j, "--tiles");
}

static pbw_status make_tree(const work *w, size_t p)
{
    char name[NAME], points[NAME], error[PBWTF_ERROR];
    pbw_options share = share_of(w, w->jobs, w->tile[p].points * sizeof(pbwt_point));        /* mapped */
    pbwtf_map map;
    pbwt_tree tree;
    pbw_status status;
    FILE *there = fopen(name_of(w, "tree", p, name), "rb");
    if (there != NULL) {                             /* an earlier run made it */
        fclose(there);
        return PBW_OK;
    }
    if (pbwtf_map_file(name_of(w, "points", p, points), NULL, &map, error) != PBW_OK) {
        return PBW_ERROR_ARGUMENT;                   /* make_trees says so, too */
    }
    pbwtf_fetch(&map, map.data, map.size);
    if (map.size != w->tile[p].points * sizeof(pbwt_point) || pbwtf_fault(&map) != NULL
        || sum_of_points((const pbwt_point *)(const void *)map.data, w->tile[p].points) != w->tile[p].points_sum) {
        pbwtf_unmap(&map);
        return PBW_ERROR_ARGUMENT;
    }
    share.progress = w->jobs > 1 ? is_interrupted : share.progress;
    status = pbwt_tree_make((int)w->s.dim, (int)p, (const pbwt_point *)(const void *)map.data,
                            map.size / sizeof(pbwt_point), &share, &tree);
    pbwtf_unmap(&map);
    if (status != PBW_OK) {
        if (status != PBW_CANCELLED) {               /* make_trees says so */
            fail(w->j, "tile %lu: %s%s", (unsigned long)p, pbw_status_string(status),
                 status == PBW_ERROR_MEMORY ? "; more --tiles need less" : "");
        }
        return status;
    }
    if (write_tree(w, &tree, name) == 0) {
        remove(points);
    } else {
        status = PBW_ERROR_BACKEND;
    }
    pbwt_tree_free(&tree);
    return status;
}

static pbw_status make_some_trees(void *arg, size_t from, size_t to)
{
    pbw_status status = PBW_OK;
    for (; from < to && status == PBW_OK; from++) {
        status = make_tree((const work *)arg, from);
    }
    return status;
}

/* As many at a time as work.jobs. */
static pbw_status for_tiles(const work *w, pbw_body *body, void *arg)
{
    pbw_options options;
    memset(&options, 0, sizeof options);
    options.threads = w->jobs;
    return pbw_for(&options, w->s.parts, 1, body, arg);
}

static int make_trees(work *w)
{
    const pbw_status status = w->s.trees ? PBW_OK : for_tiles(w, make_some_trees, w);
    char name[NAME];
    size_t p;
    w->hopeless |= status == PBW_ERROR_MEMORY && is_bound_to_limit(w);
    if (status != PBW_OK) {
        snprintf(name, sizeof name, "%s/N.points", w->scratch);
        return interrupted ? paused(w) : status == PBW_ERROR_ARGUMENT ? bad_scratch(w, name, NULL) : FAILURE;
    }
    for (p = 0; p < w->s.parts; p++) {
        if (!open_tree(w, p, name_of(w, "tree", p, name))) {
            return bad_scratch(w, name, NULL);
        }
    }
    w->s.trees = 1;
    return save_state(w);
}

/* ---- tiles ---- */

static int explain_tile(work *w, const pbwt_tile *tile, size_t p, pbw_status status)
{
    if (status == PBW_CANCELLED) {
        return paused(w);
    }
    if (w->bad > 0) {
        char name[NAME];
        return bad_scratch(w, name_of(w, "tree", w->bad - 1, name), pbwtf_fault(w->map + w->bad - 1));
    }
    w->hopeless |= status == PBW_ERROR_MEMORY ? is_bound_to_limit(w) : status != PBW_ERROR_BACKEND;
    if (status == PBW_ERROR_MEMORY) {
        const char *limit = text_of(w->j, "--memory-limit");
        limit = limit != NULL ? limit : "4G";
        return p == w->s.parts
             ? fail(w->j, "out of memory within --memory-limit %s: the tiles gave up %zu point%s, as on "
                    "surfaces, which must be triangulated at once", limit, COUNT(tile->numbers.given_up))
             : fail(w->j, "tile %lu: out of memory within --memory-limit %s: %zu point%s of its own, %lu of others, "
                    "%lu given up; more --tiles need less", (unsigned long)p, limit, COUNT(w->tree[p].count),
                    (unsigned long)tile->foreign_count, (unsigned long)tile->numbers.given_up);
    }
    return status == PBW_ERROR_BACKEND ? cannot(w, w->s.out)
         : fail(w->j, "tile %lu: %s", (unsigned long)p, pbw_status_string(status));
}

/* Trees are read by many and forgotten by one. */
static void begin_reading(workers *c)
{
    enter(c);
    while (c->forgetting) {
        await(c);
    }
    c->reading++;
    leave(c);
}

/* Returns whether the tree of tile q is as it was written. */
static int end_reading(workers *c, size_t q)
{
    const int good = pbwtf_fault(c->w->map + q) == NULL;
    enter(c);
    c->reading--;
    c->w->bad = good || c->w->bad > 0 ? c->w->bad : q + 1;
    if (c->forgetting) {
        wake(c);
    }
    leave(c);
    return good;
}

/* Forgets trees of which no tile at work is made if more of them is in memory than their share. */
static void forget_trees(workers *c)
{
    size_t q, bytes = 0;
    enter(c);
    for (q = 0; q < c->w->s.parts; q++) {
        bytes += c->at_work[q] ? 0 : pbwtf_fetched(c->w->map + q);
    }
    if (bytes < c->w->options.build.memory_limit / SHARE_OF_TREES) {
        leave(c);
        return;
    }
    while (c->forgetting) {
        await(c);
    }
    c->forgetting = 1;
    while (c->reading > 0) {
        await(c);
    }
    for (q = 0; q < c->w->s.parts; q++) {
        if (!c->at_work[q]) {
            pbwtf_forget(c->w->map + q);
        }
    }
    c->forgetting = 0;
    wake(c);
    leave(c);
}

/* The whole tree of a tile, until forget_trees after its end.  Returns whether it is as it was written. */
static int fetch_own_tree(workers *c, size_t p)
{
    pbwtf_map *map = c->w->map + p;
    begin_reading(c);
    c->at_work[p] = 1;
    pbwtf_fetch(map, map->data, map->size);
    return end_reading(c, p);
}

/* Asks and answers until the tile is finished. */
static pbw_status run_tile(workers *c, pbwt_tile *tile, size_t p)
{
    work *w = c->w;
    pbwt_served *served = (pbwt_served *)calloc(w->s.parts, sizeof *served);
    pbwt_bytes reply = { NULL, 0 };
    pbw_status status = served != NULL ? PBW_OK : PBW_ERROR_MEMORY;
    size_t q;
    int more = 1;
    while (status == PBW_OK && more) {
        status = pbwt_ask(tile, &more);
        for (q = 0; q < w->s.parts && status == PBW_OK && more; q++) {
            if (tile->request[q].size > 0) {
                begin_reading(c);
                status = pbwt_answer(w->tree + q, served + q, tile->request + q, &w->limits, w->summary[p].count,
                                     &reply);
                status = end_reading(c, q) ? status : PBW_ERROR_BACKEND;
                status = status != PBW_OK ? status : pbwt_take(tile, (int)q, reply.data, reply.size);
                pbwt_bytes_free(w->tree + q, &reply);
                forget_trees(c);
            }
        }
    }
    for (q = 0; q < w->s.parts && served != NULL; q++) {
        pbwt_served_free(w->tree + q, served + q);
    }
    free(served);
    return status;
}

static int save(const work *w, const char *what, size_t p, const void *items, size_t size, uint64_t *sum)
{
    char name[NAME];
    FILE *file;
    int good;
    errno = 0;
    file = fopen(name_of(w, what, p, name), "wb");
    good = file != NULL && (size == 0 || fwrite(items, 1, size, file) == size);
    good = (file == NULL || fclose(file) == 0) && good;
    *sum = pbwtf_sum(items, size);
    return good ? 0 : cannot(w, name);
}

/* Appends the chunk of a finished tile to the output, where it counts from then on. */
static int end_tile(work *w, pbwtf_writer *chunk, const pbwt_tile *tile, size_t p)
{
    tile_state *t = w->tile + p;
    int failed = !w->s.mesh || pbwtf_end(chunk, tile, (int)w->s.dim) ? 0 : cannot(w, w->s.out);
    failed = failed ? failed : save(w, "facets", p, tile->facets, tile->facet_count * sizeof *tile->facets,
                                    &t->facets_sum);
    failed = failed ? failed : save(w, "border", p, tile->border, tile->border_count * sizeof *tile->border,
                                    &t->border_sum);
    if (failed) {
        return failed;
    }
    t->given = tile->leftover_count;
    t->facets = tile->facet_count;
    t->border = tile->border_count;
    t->head_sum = w->s.mesh ? pbwtf_sum(&chunk->chunk, sizeof chunk->chunk) : 0;
    t->hull = tile->numbers.hull;
    t->halo = tile->numbers.halo;
    t->later = tile->numbers.later;
    t->rounds = tile->numbers.rounds;
    t->questions = tile->numbers.questions;
    t->simplices = tile->numbers.simplices;
    t->hash = tile->hash;
    t->entry.offset = w->s.size;
    t->entry.size = w->s.mesh ? pbwtf_chunk_size(&chunk->chunk) : 0;
    w->s.size += t->entry.size;
    w->s.done = (uint32_t)p + 1;
    w->s.chunks = w->s.done;
    return save_state(w);
}

/* ---- several tiles at a time: triangulated in any order, but written in the order of their numbers, so that the
   output does not depend on the number of workers.  A tile waits with its first simplex until its turn comes. */

typedef struct tile_task {
    workers *c;
    size_t tile;
    int has_turn;
    pbwt_options options;
    pbwtf_writer chunk;
} tile_task;

static int on_tile(void *user, pbw_stage stage, double done)
{
    workers *c = ((tile_task *)user)->c;
    const pbw_options *build = &c->w->j->build;
    int stop;
    if (c->w->jobs == 1) {
        return build->progress != NULL && build->progress(build->progress_user, stage, done);
    }
    enter(c);
    stop = c->stop || interrupted;
    if (!stop) {                                     /* nothing is drawn behind the words of a worker that stopped */
        begin(c->w->j, "tiles", "several at a time");
    }
    leave(c);
    return stop;
}

/* Begins the chunk once all tiles before are written; returns 0 if the workers stop. */
static int take_turn(tile_task *h)
{
    workers *c = h->c;
    work *w = c->w;
    enter(c);
    while (!h->has_turn && !c->stop && w->s.done != h->tile) {
        await(c);
    }
    if (!h->has_turn && !c->stop && w->s.mesh) {
        pbwtf_begin(&h->chunk, c->out, w->tree + h->tile, (uint32_t)h->tile,
                    (w->s.weighted ? PBWTF_WEIGHTS : 0) | (w->s.links ? PBWTF_LINKS : 0));
    }
    h->has_turn |= !c->stop;
    leave(c);
    return h->has_turn;
}

static pbw_status emit_in_turn(void *user, const pbwt_tile *tile, size_t first, size_t count, const uint32_t *corners,
                               const uint32_t *links)
{
    tile_task *h = (tile_task *)user;
    return h->has_turn || take_turn(h) ? pbwtf_emit(&h->chunk, tile, first, count, corners, links) : PBW_CANCELLED;
}

/* Writes the end of a tile, or says why it failed, and passes the turn on. */
static void end_turn(tile_task *h, const pbwt_tile *tile, pbw_status status)
{
    workers *c = h->c;
    work *w = c->w;
    const size_t p = h->tile;
    enter(c);
    if (status == PBW_OK) {
        c->failed = end_tile(w, &h->chunk, tile, p);
    } else if (!c->stop && status == PBW_ERROR_MEMORY && w->jobs > 1) {
        c->short_of_memory = 1;
    } else if (!c->stop) {
        c->failed = explain_tile(w, tile, p, status);
    }
    c->stop |= status != PBW_OK || c->failed;
    if (!c->stop) {
        report_step(w->j, "tile", now() - w->start, "%lu of %u: %zu point%s, halo %lu + %lu, %lu %s, %zu round%s, "
                    "%lu given up", (unsigned long)p + 1, w->s.parts, COUNT(w->tree[p].count),
                    (unsigned long)tile->numbers.halo, (unsigned long)tile->numbers.later,
                    (unsigned long)tile->numbers.simplices, simplices(0, (size_t)tile->numbers.simplices),
                    COUNT(tile->numbers.rounds), (unsigned long)tile->numbers.given_up);
    }
    c->at_work[p] = 0;
    wake(c);
    leave(c);
    forget_trees(c);
}

static void build_tile(workers *c, size_t p)
{
    work *w = c->w;
    pbwt_tile tile;
    tile_task h;
    pbw_status status;
    memset(&h, 0, sizeof h);
    h.c = c;
    h.tile = p;
    h.options = w->options;
    h.options.build = share_of(w, w->jobs, w->map[p].size);
    h.options.build.progress = on_tile;
    h.options.build.progress_user = &h;
    h.options.emit = w->s.mesh ? emit_in_turn : NULL;
    h.options.emit_user = &h;
    status = pbwt_open(&tile, w->tree + p, w->summary, (int)w->s.parts, &h.options);
    status = status == PBW_OK && !fetch_own_tree(c, p) ? PBW_ERROR_BACKEND : status;
    status = status != PBW_OK ? status : run_tile(c, &tile, p);
    status = status == PBW_OK && !take_turn(&h) ? PBW_CANCELLED : status;
    end_turn(&h, &tile, status);
    pbwt_close(&tile);
}

static pbw_status work_on(void *arg, size_t from, size_t to)
{
    workers *c = (workers *)arg;
    for (; from < to;) {
        size_t p;
        int stop;
        enter(c);
        p = c->next++;
        stop = c->stop;
        leave(c);
        if (stop || p >= c->w->s.parts) {
            break;
        }
        build_tile(c, p);
    }
    return PBW_OK;
}

/* Makes the output as long as that, and goes to its end. */
static int cut_output(const work *w, FILE *out, uint64_t size)
{
    errno = 0;
#ifdef _WIN32
    return fflush(out) == 0 && _chsize_s(_fileno(out), (__int64)size) == 0 && pbwtf_seek(out, size) ? 0
         : cannot(w, w->s.out);
#else
    return fflush(out) == 0 && truncate(w->s.out, (off_t)size) == 0 && pbwtf_seek(out, size) ? 0
         : cannot(w, w->s.out);
#endif
}

/* Builds tiles from the first that is not done, work.jobs at a time; fewer if memory is too small for that. */
static int build_rest(work *w, FILE *out)
{
    int failed = 0;
    while (w->s.done < w->s.parts && !failed) {
        pbw_options options;
        workers c;
        memset(&options, 0, sizeof options);
        memset(&c, 0, sizeof c);
        if (cut_output(w, out, w->s.size)) {
            return FAILURE;
        }
        c.w = w;
        c.out = out;
        c.next = w->s.done;
        c.at_work = (unsigned char *)calloc(w->s.parts, 1);
        if (c.at_work == NULL) {
            return fail(w->j, "out of memory");
        }
        options.threads = w->jobs;
        workers_start(&c);
        pbw_for(&options, (size_t)w->jobs, 1, work_on, &c);
        workers_end(&c);
        free(c.at_work);
        failed = c.failed;
        if (c.short_of_memory) {
            w->jobs /= 2;
            report_line(w->j, "little memory: on with %d at a time", w->jobs);
        }
    }
    return failed;
}

/* ---- leftovers: what tiles know of them is in their chunks, and in their borders ---- */

static int compare_ids(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

/* A tile as it was when it ended, for pbwt_leftovers; foreign points, only their ids, are allocated.  Returns 0
   without memory. */
static int recall(const work *w, const pbwtf_view *view, const pbwtf_map *border, size_t p, pbwt_tile *tile)
{
    const size_t count = (size_t)view->chunk->foreign, each = view->foreign_size;
    pbwt_vertex *foreign = (pbwt_vertex *)calloc(count + 1, sizeof *foreign);
    size_t i;
    memset(tile, 0, sizeof *tile);
    tile->dim = (int)w->s.dim;
    tile->tree = w->tree + p;
    tile->numbers.simplices = (size_t)view->chunk->simplices;
    tile->leftovers = view->given;
    tile->leftover_count = (size_t)view->chunk->given;
    tile->border = (const uint32_t *)(const void *)border->data;
    tile->border_count = border->size / sizeof(uint32_t);
    tile->foreign = foreign;
    tile->foreign_count = count;
    for (i = 0; i < count && foreign != NULL; i++) {
        memcpy(&foreign[i].point.id, view->foreign + (i + 1) * each - 2, sizeof foreign[i].point.id);
    }
    return foreign != NULL;
}

/* The ids of all points given up, ascending. */
static uint64_t *given_ids(const work *w, const pbwtf_map *chunks, size_t count)
{
    uint64_t *ids = (uint64_t *)malloc((count + 1) * sizeof *ids);
    pbwtf_view view;
    size_t p, i, n = 0;
    for (p = 0; p < w->s.parts && ids != NULL; p++) {
        const size_t lost = view_chunk(w, chunks, p, &view) ? (size_t)view.chunk->given : 0;
        for (i = 0; i < lost && n < count; i++) {
            ids[n++] = ((const pbwt_point *)pbwtf_fetch(w->map + p, w->tree[p].points + view.given[i],
                                                        sizeof(pbwt_point)))->id;
        }
    }
    if (ids != NULL) {
        qsort(ids, n, sizeof *ids, compare_ids);
    }
    return ids;
}

/* What all tiles know of the points given up, in the order of the tiles. */
static pbw_status know(work *w, const pbwtf_map *chunks, const uint64_t *ids, size_t count, pbwt_bytes *known)
{
    pbw_status status = PBW_OK;
    size_t p;
    for (p = 0; p < w->s.parts && status == PBW_OK; p++) {
        char name[NAME], error[PBWTF_ERROR], *grown = NULL;
        pbwtf_map border = { NULL, 0, NULL };
        pbwt_bytes piece = { NULL, 0 };
        pbwtf_view view;
        pbwt_tile tile;
        pbwtf_fetch(w->map + p, w->map[p].data, w->map[p].size);
        if (pbwtf_map_file(name_of(w, "border", p, name), NULL, &border, error) != PBW_OK
            || border.size != w->tile[p].border * sizeof(uint32_t)
            || pbwtf_sum(pbwtf_fetch(&border, border.data, border.size), border.size) != w->tile[p].border_sum
            || pbwtf_fault(&border) != NULL || pbwtf_fault(w->map + p) != NULL || !view_chunk(w, chunks, p, &view)) {
            pbwtf_unmap(&border);
            w->bad = p + 1;
            return PBW_ERROR_BACKEND;
        }
        status = recall(w, &view, &border, p, &tile) ? pbwt_leftovers(&tile, ids, count, &piece) : PBW_ERROR_MEMORY;
        grown = status == PBW_OK ? (char *)realloc(known->data, known->size + piece.size + 1) : NULL;
        if (grown != NULL) {
            memcpy(grown + known->size, piece.data, piece.size);
            known->data = grown;
            known->size += piece.size;
        }
        status = status == PBW_OK && grown == NULL ? PBW_ERROR_MEMORY : status;
        free((void *)(size_t)tile.foreign);
        pbwt_bytes_free(w->tree + p, &piece);
        pbwtf_unmap(&border);
        pbwtf_forget(w->map + p);
    }
    return status;
}

/* Triangulates the leftovers at once, and writes them as the last chunk. */
static int build_leftovers(work *w, FILE *out, size_t count)
{
    const size_t limit = w->options.build.memory_limit;
    pbwt_bytes known = { NULL, 0 };
    uint64_t *ids = NULL;
    char error[PBWTF_ERROR];
    pbwtf_map chunks;
    pbwtf_writer chunk;
    pbwt_options options = w->options;
    pbwt_tile tile;
    pbw_status status = PBW_ERROR_MEMORY;
    int failed;
    memset(&tile, 0, sizeof tile);
    if (!w->s.mesh) {
        w->hopeless = 1;
        return fail(w->j, "the tiles gave up %zu point%s, as on surfaces: --no-mesh does not do them", COUNT(count));
    }
    if (cut_output(w, out, w->s.size)) {
        return FAILURE;
    }
    if (pbwtf_map_file(w->s.out, NULL, &chunks, error) != PBW_OK) {
        return fail(w->j, "%s", error);
    }
    ids = given_ids(w, &chunks, count);
    status = ids != NULL ? know(w, &chunks, ids, count, &known) : PBW_ERROR_MEMORY;
    pbwtf_unmap(&chunks);
    free(ids);
    pbwtf_begin(&chunk, out, NULL, w->s.parts, (w->s.weighted ? PBWTF_WEIGHTS : 0) | (w->s.links ? PBWTF_LINKS : 0));
    options.emit = pbwtf_emit;
    options.emit_user = &chunk;
    options.build.memory_limit = limit > known.size ? limit - known.size : 1;
    status = status != PBW_OK ? status : pbwt_finish(&tile, (int)w->s.dim, (int)w->s.parts, &known, &options);
    tile.numbers.given_up = count;
    failed = status == PBW_OK ? end_tile(w, &chunk, &tile, w->s.parts) : explain_tile(w, &tile, w->s.parts, status);
    if (!failed) {
        report_step(w->j, "leftovers", now() - w->start, "%zu point%s, %lu %s", COUNT(count),
                    (unsigned long)tile.numbers.simplices, simplices(0, (size_t)tile.numbers.simplices));
    }
    pbwt_close(&tile);
    free(known.data);
    return failed;
}

/* ---- links across tiles, and the end of the file ---- */

static int link_tiles(work *w, FILE *out, uint64_t *hull)
{
    pbwt_facet *facets;
    uint64_t count = 0, at = 0, i;
    char name[NAME];
    size_t p;
    int failed = 0;
    for (p = 0; p < w->s.chunks; p++) {
        count += w->tile[p].facets;
    }
    facets = (pbwt_facet *)malloc((size_t)(count + 1) * sizeof *facets);
    if (facets == NULL) {
        return fail(w->j, "out of memory: %zu facet%s between tiles, %.0f MB", COUNT(count),
                    (double)count * 48e-6);
    }
    for (p = 0; p < w->s.chunks && !failed; p++) {
        FILE *file = fopen(name_of(w, "facets", p, name), "rb");
        const size_t own = (size_t)w->tile[p].facets;
        failed = file == NULL || fread(facets + at, sizeof *facets, own, file) != own ? cannot(w, name)
               : pbwtf_sum(facets + at, own * sizeof *facets) != w->tile[p].facets_sum
               ? bad_scratch(w, name, NULL) : 0;
        at += w->tile[p].facets;
        if (file != NULL) {
            fclose(file);
        }
    }
    *hull += failed ? 0 : pbwt_match(facets, (size_t)count);
    for (p = 0, at = 0; p < w->s.chunks && !failed; p++) {
        tile_state *t = w->tile + p;
        t->entry.across_checksum = 0;
        errno = 0;
        failed = !pbwtf_seek(out, t->entry.offset + t->entry.size - t->facets * 8);
        for (i = 0; i < t->facets && !failed; i++, at++) {
            failed = fwrite(&facets[at].to, 8, 1, out) != 1;
            t->entry.across_checksum = pbwtf_checksum(t->entry.across_checksum, &facets[at].to, 8);
        }
        failed = failed || fflush(out) != 0 ? cannot(w, w->s.out) : 0;
    }
    free(facets);
    return failed;
}

static int finish_file(work *w, FILE *out)
{
    pbwtf_header header;
    pbw_hash_sums sums = { 0, 0 };
    uint64_t hull = 0, halo = 0, rounds = 0;
    size_t p;
    int failed;
    memset(&header, 0, sizeof header);
    for (p = 0; p < w->s.chunks; p++) {
        w->tile[p].entry.first_simplex = header.simplices;
        header.simplices += w->tile[p].simplices;
        sums.points += w->tile[p].hash.points;
        sums.simplices += w->tile[p].hash.simplices;
        hull += w->tile[p].hull;
        halo += w->tile[p].halo + w->tile[p].later;
        rounds = w->tile[p].rounds > rounds ? w->tile[p].rounds : rounds;
        header.duplicates += p < w->s.parts ? w->tree[p].duplicates : 0;
    }
    failed = w->s.links ? link_tiles(w, out, &hull) : 0;
    header.dim = w->s.dim;
    header.flags = (w->s.weighted ? PBWTF_WEIGHTS : 0) | (w->s.links ? PBWTF_LINKS : 0);
    header.chunks = w->s.chunks;
    header.tiles = w->s.parts;
    header.points = w->s.points;
    header.hull = w->s.links ? hull : 0;
    header.table = w->s.size;
    header.size = w->s.size + header.chunks * sizeof(pbwtf_entry);
    pbwtf_seal(&header, &sums);
    failed = failed || cut_output(w, out, header.table);
    for (p = 0; p < w->s.chunks && !failed; p++) {
        failed = fwrite(&w->tile[p].entry, sizeof(pbwtf_entry), 1, out) != 1;
    }
    failed = failed || fflush(out) != 0 || !pbwtf_seek(out, 0) || fwrite(&header, sizeof header, 1, out) != 1
          || fflush(out) != 0 ? cannot(w, w->s.out) : 0;
    if (!failed) {
        char on_hull[48] = "";
        if (w->s.links) {
            snprintf(on_hull, sizeof on_hull, "%zu facet%s on the hull, ", COUNT(hull));
        }
        report_line(w->j, "%zu %s, %s%zu duplicate%s, halo %.1f %%, %zu round%s, hash %016llx",
                    (size_t)header.simplices, simplices(0, (size_t)header.simplices), on_hull,
                    COUNT(header.duplicates), 100 * (double)halo / (double)(w->s.points > 0 ? w->s.points : 1),
                    COUNT(rounds), (unsigned long long)header.hash);
    }
    return failed;
}

/* Opens the output of an earlier run, or creates it.  NULL: failed, and said so. */
static FILE *open_output(work *w)
{
    static const pbwtf_header nothing;
    const int is_there = w->s.size > 0;
    struct stat about;
    char name[sizeof w->s.out];
    FILE *out;
    errno = 0;
    snprintf(name, sizeof name, "%s", w->j->outputs > 0 ? w->j->output[0] : w->scratch);
    out = is_there ? fopen(w->s.out, "rb+") : pbwtf_create(name, w->s.out, sizeof w->s.out);
    if (out == NULL || stat(w->s.out, &about) != 0 || (!is_there && fwrite(&nothing, sizeof nothing, 1, out) != 1)) {
        cannot(w, w->s.out);
        if (out != NULL) {
            fclose(out);
        }
        return NULL;
    }
    w->s.number = (uint64_t)about.st_ino;
    w->s.size = is_there ? w->s.size : sizeof nothing;
    if (save_state(w)) {
        fclose(out);
        return NULL;
    }
    return out;
}

static int build_tiles(work *w)
{
    FILE *out = open_output(w);
    uint64_t left_over = 0;
    size_t p;
    int failed = out == NULL ? FAILURE : build_rest(w, out);
    for (p = 0; p < w->s.parts && !failed; p++) {
        left_over += w->tile[p].given;
    }
    if (left_over > 0 && w->s.chunks == w->s.parts && !failed) {
        failed = build_leftovers(w, out, (size_t)left_over);
    }
    failed = failed ? failed : finish_file(w, out);
    if (out != NULL && fclose(out) != 0 && !failed) {
        failed = cannot(w, w->s.out);
    }
    return failed;
}

/* ---- the command ---- */

/* Returns the bytes that a tile holds for each point of its own: with a tenth of others, its tree, and its part of
   the share of all other trees. */
static double bytes_each(const work *w)
{
    return (w->s.dim == 3 ? 458 : 245) * (1 + 1.0 / (SHARE_OF_TREES - 1));
}

/* Tiles of which some fit at a time, whatever the number of threads, unless they would be small. */
static uint32_t parts_for(const work *w, double limit)
{
    const double n = (double)w->s.points, need = ceil(bytes_each(w) * n / limit);
    const double parts = fmax(need, fmin(AT_A_TIME * need, floor(n / 250000)));
    return (uint32_t)number_of(w->j, "--tiles", parts < 1 ? 1 : parts > MOST_TILES ? MOST_TILES : parts);
}

/* How many tiles fit at a time, if each gets at least one thread. */
static int jobs_for(work *w)
{
    const pbw_options *build = &w->options.build;
    const double tile = bytes_each(w) * (double)w->s.points / w->s.parts;
    double jobs = floor((double)build->memory_limit / (tile > 1 ? tile : 1));
#ifdef _WIN32
    jobs = 1;
#else
    if (build->threads == 0) {
        const long cores = sysconf(_SC_NPROCESSORS_ONLN);
        w->options.build.threads = cores > 256 ? 256 : cores > 1 ? (int)cores : 1;
    }
#endif
    jobs = fmin(fmin(jobs, build->threads), w->s.parts);
    return jobs > 1 ? (int)jobs : 1;
}

static int prepare(work *w)
{
    const char *name = w->j->outputs > 0 ? w->j->output[0] : w->j->input != NULL ? w->j->input : "points";
    memcpy(w->s.magic, "PBWSTAT5", 8);
    w->s.mesh = !is_given(w->j, "--no-mesh");
    w->s.links = w->s.mesh && !is_given(w->j, "--no-links");
    w->options.build = w->j->build;
    w->options.build.memory_limit = w->j->build.memory_limit > 0 ? w->j->build.memory_limit : (size_t)1 << 32;
    w->s.parts = parts_for(w, (double)w->options.build.memory_limit);
    w->jobs = jobs_for(w);
    w->tile = (tile_state *)calloc(w->s.parts + 1, sizeof *w->tile);
    w->map = (pbwtf_map *)calloc(w->s.parts, sizeof *w->map);
    w->sums = (uint64_t **)calloc(w->s.parts, sizeof *w->sums);
    w->tree = (pbwt_tree *)calloc(w->s.parts, sizeof *w->tree);
    w->summary = (pbwt_summary *)calloc(w->s.parts, sizeof *w->summary);
    if (w->tile == NULL || w->map == NULL || w->sums == NULL || w->tree == NULL || w->summary == NULL) {
        return fail(w->j, "out of memory");
    }
    w->options.weighted = (int)w->s.weighted;
    w->options.no_links = !w->s.links;
    w->limits.work = (size_t)number_of(w->j, "--work", 0);
    w->options.halo = number_of(w->j, "--halo", 0);
    if (is_given(w->j, "--scratch")) {
        snprintf(w->scratch, sizeof w->scratch, "%s", text_of(w->j, "--scratch"));
    } else {
        snprintf(w->scratch, sizeof w->scratch, "%s.scratch", name);
    }
    if (take_scratch(w)) {
        return FAILURE;
    }
    begin(w->j, "read", name);
    w->s.input_mark = mark_of_input(w);
    load_state(w);
    return 0;
}

static void close_maps(work *w)
{
    size_t p;
    for (p = 0; w->map != NULL && w->sums != NULL && p < w->s.parts; p++) {
        pbwtf_unmap(w->map + p);
        free(w->sums[p]);
        w->sums[p] = NULL;
    }
}

/* Removes the scratch files, and leaves their folder. */
static void clean(work *w)
{
    char name[NAME];
    close_maps(w);
    remove_scratch(w, w->s.parts);
    snprintf(name, sizeof name, "%s/state.part", w->scratch);
    remove(name);
    snprintf(name, sizeof name, "%s/state", w->scratch);
    remove(name);
    if (w->lock >= 0) {
        pbwtf_leave(w->scratch, w->lock, 1);
        w->lock = -1;
    }
}

static int run_tiles(job *j)
{
    work *w;
    int failed;
    if (j->outputs != !is_given(j, "--no-mesh")) {
        return complain("one output is needed, with --no-mesh none; see pbw tiles --help");
    }
    w = (work *)calloc(1, sizeof *w);
    if (w == NULL) {
        return fail(j, "out of memory");
    }
    w->j = j;
    w->lock = -1;
    w->start = now();
    failed = open_input(w);
    failed = failed ? failed : prepare(w);
    failed = failed || w->s.distributed ? failed : distribute(w);
    failed = failed ? failed : make_trees(w);
    failed = failed ? failed : build_tiles(w);
    if (!failed && (w->s.mesh ? rename(w->s.out, j->output[0]) : remove(w->s.out)) != 0) {
        failed = cannot(w, w->s.out);
    }
    if (w->hopeless && *w->s.out != 0) {
        remove(w->s.out);
    }
    if (w->hopeless || !failed) {
        clean(w);
    }
    if (!failed) {
        j->written = j->outputs;
        report_step(j, "all", now() - w->start, "%zu tile%s", COUNT(w->s.parts));
    }
    close_maps(w);
    if (w->lock >= 0) {
        pbwtf_leave(w->scratch, w->lock, 0);
    }
    if (w->input != NULL) {
        fclose(w->input);
    }
    free(w->tile);
    free(w->map);
    free(w->sums);
    free(w->tree);
    free(w->summary);
    free(w);
    return failed;
}

const command command_tiles = {
    .name = "tiles",
    .summary = "triangulate what memory does not hold",
    .usage =
    "usage: pbw tiles [options] points -o mesh.pbwt\n"
    "\n"
    "Triangulates points tile by tile within a limit of memory, into a file that has simplices, links across tiles\n"
    "and a hash: the same triangulation as pbw mesh makes at once.  A run that was stopped, or found the disk full,\n"
    "goes on when it is started again, as does one that was short of memory with the same --tiles and more of it.\n"
    "\n"
    "input:   .bin, doubles x y z (with --dim 2: x y; with --weights w: and a weight): read piece by piece;\n"
    "         or as for pbw mesh, then in memory\n"
    "output:  .pbwt: see pbw_tilefile.h; pbw check, pbw hash and pbw convert read it\n"
    "\n",
    .writes = "pbwt",
    .options = { tiles_options, input_options, weight_options, build_options, output_options, common_options, NULL },
    .run = run_tiles,
};
