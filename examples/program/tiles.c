/* tiles.c: pbw tiles: triangulates points that memory does not hold, tile by tile, into a .pbwt file.

   Beside the output, in a folder of scratch files: `state`, replaced as a whole after each step, so that a run that
   was killed or had no room on the disk goes on; all go when none could, as of bad input;
   N.points (records of tile N as they come), N.tree (sorted, with boxes), N.facets (to link), N.border (simplices
   with a corner that may be given up). */
#include "program.h"
#include "pbw_tilefile.h"
#include <errno.h>
#include <sys/stat.h>
#include <sys/types.h>
#ifdef _WIN32
#include <direct.h>
#define make_folder(path) _mkdir(path)
#else
#include <pthread.h>
#include <unistd.h>
#define make_folder(path) mkdir(path, 0777)
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
    uint64_t given, facets, hull, halo, later, rounds, questions, simplices;
    pbw_hash_sums hash;
    pbwtf_entry entry;
} tile_state;

typedef struct state {
    char magic[8];                                   /* "PBWSTAT3" */
    uint32_t dim, weighted, links, parts, mesh, unused;
    uint64_t points, input_mark;                     /* input_mark: differs for another input, see mark_of_input */
    uint32_t distributed, trees, done, chunks;       /* steps that are finished; tiles done, in their order */
    uint64_t size;                                   /* of the output so far */
} state;

typedef struct tree_head { pbwt_summary summary; uint64_t duplicates; } tree_head;

typedef struct work {
    job *j;
    state s;
    tile_state *tile;                                /* parts + 1 */
    char scratch[1024], out[1040];                   /* out: the output while it grows */
    FILE *input;                                     /* .bin; else the points are in the cloud */
    pbwtf_map *map;
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

/* ---- the state */

static int save_state(const work *w)
{
    char name[NAME], part[NAME];
    FILE *file;
    int good;
    snprintf(name, sizeof name, "%s/state", w->scratch);
    snprintf(part, sizeof part, "%s/state.part", w->scratch);
    errno = 0;
    file = fopen(part, "wb");
    good = file != NULL && fwrite(&w->s, sizeof w->s, 1, file) == 1
        && fwrite(w->tile, sizeof *w->tile, w->s.parts + 1, file) == w->s.parts + 1;
    good = (file == NULL || fclose(file) == 0) && good;
    return good && rename(part, name) == 0 ? 0 : cannot(w, name);
}

static void remove_scratch(const work *w, size_t parts)
{
    static const char *const kinds[] = { "points", "tree", "facets", "border" };
    char name[NAME];
    size_t p, k;
    for (p = 0; p <= parts; p++) {
        for (k = 0; k < 4; k++) {
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
        if (fseek(w->input, (long)(at * record), SEEK_SET) == 0 && fread(row, record, 1, w->input) == 1) {
            mark = pbwtf_checksum(mark, row, record);
        }
    }
    return mark;
}

/* Takes up what an earlier run left, if it was of the same input and options and its output is there; else removes
   it. */
static void load_state(work *w)
{
    char name[NAME];
    struct stat output;
    state s;
    FILE *file;
    int taken_up;
    memset(&s, 0, sizeof s);
    snprintf(name, sizeof name, "%s/state", w->scratch);
    file = fopen(name, "rb");
    taken_up = file != NULL && fread(&s, sizeof s, 1, file) == 1 && memcmp(s.magic, w->s.magic, 8) == 0
        && s.dim == w->s.dim && s.weighted == w->s.weighted && s.links == w->s.links && s.mesh == w->s.mesh
        && s.parts == w->s.parts && s.points == w->s.points && s.input_mark == w->s.input_mark
        && (s.size == 0 || (stat(w->out, &output) == 0 && (uint64_t)output.st_size >= s.size))
        && fread(w->tile, sizeof *w->tile, s.parts + 1, file) == s.parts + 1;
    if (taken_up) {
        w->s = s;
        note(w->j, "going on: %u of %zu tile%s %s finished", s.done, COUNT(s.parts), s.parts == 1 ? "is" : "are");
    } else {
        memset(w->tile, 0, (w->s.parts + 1) * sizeof *w->tile);
        remove_scratch(w, s.parts > w->s.parts && s.parts <= MOST_TILES ? s.parts : w->s.parts);
    }
    if (file != NULL) {
        fclose(file);
    }
}

/* ---- input */

static int open_input(work *w)
{
    job *j = w->j;
    const char *dot = j->input != NULL ? strrchr(j->input, '.') : NULL;
    uint64_t record;
    long size;
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
    size = w->input != NULL && fseek(w->input, 0, SEEK_END) == 0 ? ftell(w->input) : -1;
    if (size < 0) {
        return fail(j, "%s: %s", j->input, strerror(errno));
    }
    if ((uint64_t)size % record != 0) {
        return fail(j, "%s: truncated: its size, %ld, is no multiple of %lu, that of a record", j->input, size,
                    (unsigned long)record);
    }
    w->s.points = (uint64_t)size / record;
    note(j, "%zu point%s in %uD%s", COUNT(w->s.points), w->s.dim, w->s.weighted ? ", weighted" : "");
    return 0;
}

/* Reads points from..from+count-1, from where `file` stands.  Returns how many are there and finite, up to the first
   that is not. */
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

/* ---- threads at work: readers of the input, then builders of tiles */

typedef struct crew {
    work *w;
    FILE *out;
    size_t next;                                     /* the tile to begin */
    uint64_t read;                                   /* points that are distributed */
    unsigned char *started;                          /* per tile: its file is there */
    int stop, failed, short_of_memory;
#ifndef _WIN32
    pthread_mutex_t lock;                            /* for all of the crew, the report and work.s.done */
    pthread_cond_t turn;
#endif
} crew;

#ifdef _WIN32                                        /* one at a time */
enum { READERS = 1 };
static void crew_start(crew *c) { (void)c; }
static void crew_end(crew *c) { (void)c; }
static void enter(crew *c) { (void)c; }
static void leave(crew *c) { (void)c; }
static void await(crew *c) { c->stop = 1; }
static void wake(crew *c) { (void)c; }
#else
enum { READERS = 256 };
static void crew_start(crew *c)
{
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->turn, NULL);
}

static void crew_end(crew *c)
{
    pthread_cond_destroy(&c->turn);
    pthread_mutex_destroy(&c->lock);
}

static void enter(crew *c) { pthread_mutex_lock(&c->lock); }
static void leave(crew *c) { pthread_mutex_unlock(&c->lock); }
static void await(crew *c) { pthread_cond_wait(&c->turn, &c->lock); }
static void wake(crew *c) { pthread_cond_broadcast(&c->turn); }
#endif

/* ---- distribution */

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
        if (w->input != NULL && fseek(w->input, (long)(at * record), SEEK_SET) != 0) {
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

static int flush_points(crew *c, size_t tile, const pbwt_point *points, size_t count)
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
    crew c;
    const pbwt_cut *cuts;
    size_t readers, each;                            /* room of each for points: of each tile and of the input */
} reading;

/* Writes the points of a tile that a reader has, unless the crew stops. */
static void pass_on(crew *c, size_t tile, const pbwt_point *points, size_t count)
{
    enter(c);
    if (!c->stop) {
        c->failed = flush_points(c, tile, points, count);
        c->stop = c->failed;
    }
    leave(c);
}

/* Sorts points of the input, where `file` stands; used: points in the room of each tile. */
static void distribute_run(reading *r, FILE *file, uint64_t from, uint64_t to, pbwt_point *room, size_t *used)
{
    crew *c = &r->c;
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
    const int good = w->input == NULL || (file != NULL && fseek(file, (long)(from * record), SEEK_SET) == 0);
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
        crew_start(&r.c);
        pbw_for(&options, r.readers, 1, read_share, &r);
        crew_end(&r.c);
        failed = r.c.failed ? r.c.failed : r.c.stop ? stopped(w->j) : 0;
    }
    free(cuts);
    free(r.c.started);
    w->s.distributed = !failed;
    return failed ? failed : save_state(w);
}

/* ---- trees */

static int write_tree(const work *w, const pbwt_tree *tree, const char *name)
{
    char part[NAME + 8];
    tree_head head;
    FILE *file;
    int good;
    memset(&head, 0, sizeof head);
    pbwt_summarise(tree, &head.summary);
    head.duplicates = tree->duplicates;
    snprintf(part, sizeof part, "%s.part", name);
    errno = 0;
    file = fopen(part, "wb");
    good = file != NULL && fwrite(&head, sizeof head, 1, file) == 1
        && fwrite(tree->points, sizeof *tree->points, tree->count, file) == tree->count
        && fwrite(tree->boxes, sizeof *tree->boxes, tree->box_count, file) == tree->box_count;
    good = (file == NULL || fclose(file) == 0) && good;
    return good && rename(part, name) == 0 ? 0 : cannot(w, name);
}

/* The options of one tile when `jobs` are at work: a share of the threads and of the memory. */
static pbw_options share_of(const work *w, int jobs)
{
    pbw_options share = w->options.build;
    share.threads = share.threads > jobs ? share.threads / jobs : 1;
    share.memory_limit /= (size_t)jobs;
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
    pbw_options share = share_of(w, w->jobs);
    pbwtf_map map;
    pbwt_tree tree;
    pbw_status status;
    FILE *there = fopen(name_of(w, "tree", p, name), "rb");
    if (there != NULL) {                             /* an earlier run made it */
        fclose(there);
        return PBW_OK;
    }
    if (!pbwtf_map_file(name_of(w, "points", p, points), &map, error)) {
        fail(w->j, "%s", error);
        return PBW_ERROR_BACKEND;
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

/* A scratch file of an earlier run is not what that wrote. */
static int bad_scratch(work *w, const char *name)
{
    w->hopeless = 1;
    return fail(w->j, "%s: missing or truncated: scratch files are removed, start again", name);
}

static int make_trees(work *w)
{
    const pbw_status status = w->s.trees ? PBW_OK : for_tiles(w, make_some_trees, w);
    char name[NAME], error[PBWTF_ERROR];
    size_t p;
    w->hopeless |= status == PBW_ERROR_MEMORY && is_bound_to_limit(w);
    if (status != PBW_OK) {
        return interrupted ? stopped(w->j) : FAILURE;
    }
    for (p = 0; p < w->s.parts; p++) {
        tree_head head;
        if (!pbwtf_map_file(name_of(w, "tree", p, name), w->map + p, error) || w->map[p].size < sizeof head) {
            return bad_scratch(w, name);
        }
        memcpy(&head, w->map[p].data, sizeof head);
        w->summary[p] = head.summary;
        if (w->map[p].size != sizeof head + head.summary.count * sizeof(pbwt_point)
                              + pbwt_boxes_of((size_t)head.summary.count) * sizeof(pbwt_box)) {
            return bad_scratch(w, name);
        }
        pbwt_tree_over((int)w->s.dim, (int)p, w->summary + p,
                       (const pbwt_point *)(const void *)(w->map[p].data + sizeof head),
                       (const pbwt_box *)(const void *)(w->map[p].data + sizeof head
                                                        + head.summary.count * sizeof(pbwt_point)), w->tree + p);
        w->tree[p].duplicates = (size_t)head.duplicates;
    }
    w->s.trees = 1;
    return save_state(w);
}

/* ---- tiles */

static int explain_tile(work *w, const pbwt_tile *tile, size_t p, pbw_status status)
{
    if (status == PBW_CANCELLED) {
        return stopped(w->j);
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
    return status == PBW_ERROR_BACKEND ? cannot(w, w->out)
         : fail(w->j, "tile %lu: %s", (unsigned long)p, pbw_status_string(status));
}

/* Asks and answers until the tile is finished. */
static pbw_status run_tile(const work *w, pbwt_tile *tile, size_t p)
{
    pbwt_served *served = (pbwt_served *)calloc(w->s.parts, sizeof *served);
    pbwt_bytes reply = { NULL, 0 };
    pbw_status status = served != NULL ? PBW_OK : PBW_ERROR_MEMORY;
    size_t q;
    int more = 1;
    while (status == PBW_OK && more) {
        status = pbwt_ask(tile, &more);
        for (q = 0; q < w->s.parts && status == PBW_OK && more; q++) {
            if (tile->request[q].size > 0) {
                status = pbwt_answer(w->tree + q, served + q, tile->request + q, &w->limits, w->summary[p].count,
                                     &reply);
                status = status != PBW_OK ? status : pbwt_take(tile, (int)q, reply.data, reply.size);
                pbwt_bytes_free(w->tree + q, &reply);
            }
        }
    }
    for (q = 0; q < w->s.parts && served != NULL; q++) {
        pbwt_served_free(w->tree + q, served + q);
    }
    free(served);
    return status;
}

static int save(const work *w, const char *what, size_t p, const void *items, size_t count, size_t size)
{
    char name[NAME];
    FILE *file;
    int good;
    errno = 0;
    file = fopen(name_of(w, what, p, name), "wb");
    good = file != NULL && fwrite(items, size, count, file) == count;
    good = (file == NULL || fclose(file) == 0) && good;
    return good ? 0 : cannot(w, name);
}

/* Appends the chunk of a finished tile to the output, where it counts from then on. */
static int end_tile(work *w, pbwtf_writer *chunk, const pbwt_tile *tile, size_t p)
{
    tile_state *t = w->tile + p;
    int failed = !w->s.mesh || pbwtf_end(chunk, tile, (int)w->s.dim) ? 0 : cannot(w, w->out);
    failed = failed ? failed : save(w, "facets", p, tile->facets, tile->facet_count, sizeof *tile->facets);
    failed = failed ? failed : save(w, "border", p, tile->border, tile->border_count, sizeof *tile->border);
    if (failed) {
        return failed;
    }
    t->given = tile->leftover_count;
    t->facets = tile->facet_count;
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

/* ---- several at a time: triangulated in any order, written in their own, so that the output does not depend on how
   many.  A tile whose turn has not come waits with its first simplex. */

typedef struct hand {
    crew *c;
    size_t tile;
    int has_turn;
    pbwt_options options;
    pbwtf_writer chunk;
} hand;

static int on_tile(void *user, pbw_stage stage, double done)
{
    crew *c = ((hand *)user)->c;
    const pbw_options *build = &c->w->j->build;
    int stop;
    if (c->w->jobs == 1) {
        return build->progress != NULL && build->progress(build->progress_user, stage, done);
    }
    enter(c);
    stop = c->stop || interrupted;
    leave(c);
    return stop;
}

/* Begins the chunk once all tiles before are written; returns 0 if the crew stops. */
static int take_turn(hand *h)
{
    crew *c = h->c;
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
    hand *h = (hand *)user;
    return h->has_turn || take_turn(h) ? pbwtf_emit(&h->chunk, tile, first, count, corners, links) : PBW_CANCELLED;
}

/* Writes the end of a tile, or says why it failed, and passes the turn on. */
static void end_turn(hand *h, const pbwt_tile *tile, pbw_status status)
{
    crew *c = h->c;
    work *w = c->w;
    const size_t p = h->tile;
    size_t q;
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
        say(w->j, "tile", now() - w->start, "%lu of %u: %zu point%s, halo %lu + %lu, %lu %s, %zu round%s, "
            "%lu given up", (unsigned long)p + 1, w->s.parts, COUNT(w->tree[p].count),
            (unsigned long)tile->numbers.halo, (unsigned long)tile->numbers.later,
            (unsigned long)tile->numbers.simplices, simplices(0, (size_t)tile->numbers.simplices),
            COUNT(tile->numbers.rounds), (unsigned long)tile->numbers.given_up);
    }
    wake(c);
    leave(c);
    for (q = 0; q < w->s.parts; q++) {
        pbwtf_forget(w->map + q);
    }
}

static void build_tile(crew *c, size_t p)
{
    work *w = c->w;
    pbwt_tile tile;
    hand h;
    pbw_status status;
    memset(&h, 0, sizeof h);
    h.c = c;
    h.tile = p;
    h.options = w->options;
    h.options.build = share_of(w, w->jobs);
    h.options.build.progress = on_tile;
    h.options.build.progress_user = &h;
    h.options.emit = w->s.mesh ? emit_in_turn : NULL;
    h.options.emit_user = &h;
    status = pbwt_open(&tile, w->tree + p, w->summary, (int)w->s.parts, &h.options);
    status = status != PBW_OK ? status : run_tile(w, &tile, p);
    status = status == PBW_OK && !take_turn(&h) ? PBW_CANCELLED : status;
    end_turn(&h, &tile, status);
    pbwt_close(&tile);
}

static pbw_status work_on(void *arg, size_t from, size_t to)
{
    crew *c = (crew *)arg;
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

/* Builds tiles from the first that is not done, work.jobs at a time; fewer if memory is too small for that. */
static int build_rest(work *w, FILE *out)
{
    int failed = 0;
    while (w->s.done < w->s.parts && !failed) {
        pbw_options options;
        crew c;
        memset(&options, 0, sizeof options);
        memset(&c, 0, sizeof c);
        errno = 0;
#ifndef _WIN32
        failed = fflush(out) != 0 || truncate(w->out, (off_t)w->s.size) != 0;
#endif
        if (failed || fseek(out, (long)w->s.size, SEEK_SET) != 0) {
            return cannot(w, w->out);
        }
        c.w = w;
        c.out = out;
        c.next = w->s.done;
        options.threads = w->jobs;
        crew_start(&c);
        pbw_for(&options, (size_t)w->jobs, 1, work_on, &c);
        crew_end(&c);
        failed = c.failed;
        if (c.short_of_memory) {
            w->jobs /= 2;
            note(w->j, "little memory: on with %d at a time", w->jobs);
        }
    }
    return failed;
}

/* ---- leftovers: what tiles know of them is in their chunks, and in their borders */

static int compare_ids(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

/* A finished chunk of the output that is not complete yet. */
static int view_chunk(const work *w, const pbwtf_map *chunks, size_t p, pbwtf_view *view)
{
    char error[PBWTF_ERROR];
    pbwtf_header header;
    memset(&header, 0, sizeof header);
    header.dim = w->s.dim;
    header.flags = (w->s.weighted ? PBWTF_WEIGHTS : 0) | (w->s.links ? PBWTF_LINKS : 0);
    header.tiles = w->s.parts;
    return pbwtf_view_at(chunks, &header, &w->tile[p].entry, p, view, error);
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
            ids[n++] = w->tree[p].points[view.given[i]].id;
        }
    }
    if (ids != NULL) {
        qsort(ids, n, sizeof *ids, compare_ids);
    }
    return ids;
}

/* What all tiles know of the points given up, in the order of the tiles. */
static pbw_status know(const work *w, const pbwtf_map *chunks, const uint64_t *ids, size_t count, pbwt_bytes *known)
{
    pbw_status status = PBW_OK;
    size_t p;
    for (p = 0; p < w->s.parts && status == PBW_OK; p++) {
        char name[NAME], error[PBWTF_ERROR], *grown = NULL;
        pbwtf_map border = { NULL, 0 };
        pbwt_bytes piece = { NULL, 0 };
        pbwtf_view view;
        pbwt_tile tile;
        if (!pbwtf_map_file(name_of(w, "border", p, name), &border, error) || !view_chunk(w, chunks, p, &view)) {
            pbwtf_unmap(&border);
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
    if (fseek(out, (long)w->s.size, SEEK_SET) != 0 || !pbwtf_map_file(w->out, &chunks, error)) {
        return cannot(w, w->out);
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
        say(w->j, "leftovers", now() - w->start, "%zu point%s, %lu %s", COUNT(count),
            (unsigned long)tile.numbers.simplices, simplices(0, (size_t)tile.numbers.simplices));
    }
    pbwt_close(&tile);
    free(known.data);
    return failed;
}

/* ---- links across tiles, and the end of the file */

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
        failed = file == NULL || fread(facets + at, sizeof *facets, own, file) != own ? cannot(w, name) : 0;
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
        failed = fseek(out, (long)(t->entry.offset + t->entry.size - t->facets * 8), SEEK_SET) != 0;
        for (i = 0; i < t->facets && !failed; i++, at++) {
            failed = fwrite(&facets[at].to, 8, 1, out) != 1;
            t->entry.across_checksum = pbwtf_checksum(t->entry.across_checksum, &facets[at].to, 8);
        }
        failed = failed || fflush(out) != 0 ? cannot(w, w->out) : 0;
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
    errno = 0;
    failed = failed || fseek(out, (long)header.table, SEEK_SET) != 0;
    for (p = 0; p < w->s.chunks && !failed; p++) {
        failed = fwrite(&w->tile[p].entry, sizeof(pbwtf_entry), 1, out) != 1;
    }
    failed = failed || fflush(out) != 0 || fseek(out, 0, SEEK_SET) != 0
          || fwrite(&header, sizeof header, 1, out) != 1 || fflush(out) != 0 ? cannot(w, w->out) : 0;
    if (!failed) {
        char on_hull[48] = "";
        if (w->s.links) {
            snprintf(on_hull, sizeof on_hull, "%zu facet%s on the hull, ", COUNT(hull));
        }
        note(w->j, "%zu %s, %s%zu duplicate%s, halo %.1f %%, %zu round%s, hash %016llx", (size_t)header.simplices,
             simplices(0, (size_t)header.simplices), on_hull, COUNT(header.duplicates),
             100 * (double)halo / (double)(w->s.points > 0 ? w->s.points : 1), COUNT(rounds),
             (unsigned long long)header.hash);
    }
    return failed;
}

static int build_tiles(work *w)
{
    FILE *out;
    uint64_t left_over = 0;
    size_t p;
    int failed = 0;
    errno = 0;
    out = fopen(w->out, w->s.size > 0 ? "rb+" : "wb+");
    if (out != NULL && w->s.size == 0) {
        static const pbwtf_header nothing;
        failed = fwrite(&nothing, sizeof nothing, 1, out) != 1;
        w->s.size = sizeof nothing;
    }
    failed = failed || out == NULL ? cannot(w, w->out) : build_rest(w, out);
    for (p = 0; p < w->s.parts && !failed; p++) {
        left_over += w->tile[p].given;
    }
    if (left_over > 0 && w->s.chunks == w->s.parts && !failed) {
        failed = build_leftovers(w, out, (size_t)left_over);
    }
    failed = failed ? failed : finish_file(w, out);
    if (out != NULL && fclose(out) != 0 && !failed) {
        failed = cannot(w, w->out);
    }
    return failed;
}

/* ---- the command */

/* Bytes that a tile holds for each point of its own, with a tenth of others and what it reads of files. */
static double bytes_each(const work *w)
{
    return w->s.dim == 3 ? 410 : 200;
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
    memcpy(w->s.magic, "PBWSTAT3", 8);
    w->s.mesh = !is_given(w->j, "--no-mesh");
    w->s.links = w->s.mesh && !is_given(w->j, "--no-links");
    w->options.build = w->j->build;
    w->options.build.memory_limit = w->j->build.memory_limit > 0 ? w->j->build.memory_limit : (size_t)1 << 32;
    w->s.parts = parts_for(w, (double)w->options.build.memory_limit);
    w->jobs = jobs_for(w);
    w->tile = (tile_state *)calloc(w->s.parts + 1, sizeof *w->tile);
    w->map = (pbwtf_map *)calloc(w->s.parts, sizeof *w->map);
    w->tree = (pbwt_tree *)calloc(w->s.parts, sizeof *w->tree);
    w->summary = (pbwt_summary *)calloc(w->s.parts, sizeof *w->summary);
    if (w->tile == NULL || w->map == NULL || w->tree == NULL || w->summary == NULL) {
        return fail(w->j, "out of memory");
    }
    w->options.weighted = (int)w->s.weighted;
    w->options.no_links = !w->s.links;
    w->limits.work = (size_t)number_of(w->j, "--work", 0);
    w->options.halo = number_of(w->j, "--halo", 0);
    snprintf(w->out, sizeof w->out, "%s.part", name);
    if (is_given(w->j, "--scratch")) {
        snprintf(w->scratch, sizeof w->scratch, "%s", text_of(w->j, "--scratch"));
    } else {
        snprintf(w->scratch, sizeof w->scratch, "%s.scratch", name);
    }
    errno = 0;
    if (make_folder(w->scratch) != 0 && errno != EEXIST) {
        return cannot(w, w->scratch);
    }
    w->s.input_mark = mark_of_input(w);
    load_state(w);
    return 0;
}

static void clean(work *w)
{
    char name[NAME];
    size_t p;
    for (p = 0; p < w->s.parts; p++) {
        pbwtf_unmap(w->map + p);
    }
    remove_scratch(w, w->s.parts);
    snprintf(name, sizeof name, "%s/state", w->scratch);
    remove(name);
    remove(w->scratch);
}

static int run(job *j)
{
    work *w;
    size_t p;
    int failed;
    if (j->outputs != !is_given(j, "--no-mesh")) {
        return complain("one output is needed, with --no-mesh none; see pbw tiles --help");
    }
    w = (work *)calloc(1, sizeof *w);
    if (w == NULL) {
        return fail(j, "out of memory");
    }
    w->j = j;
    w->start = now();
    failed = open_input(w);
    failed = failed ? failed : prepare(w);
    failed = failed || w->s.distributed ? failed : distribute(w);
    failed = failed ? failed : make_trees(w);
    failed = failed ? failed : build_tiles(w);
    if (!failed && (w->s.mesh ? rename(w->out, j->output[0]) : remove(w->out)) != 0) {
        failed = cannot(w, w->out);
    }
    if (w->hopeless) {
        clean(w);
        remove(w->out);
    }
    if (!failed) {
        clean(w);
        j->written = j->outputs;
        say(j, "all", now() - w->start, "%zu tile%s", COUNT(w->s.parts));
    }
    for (p = 0; p < w->s.parts && w->map != NULL; p++) {
        pbwtf_unmap(w->map + p);
    }
    if (w->input != NULL) {
        fclose(w->input);
    }
    free(w->tile);
    free(w->map);
    free(w->tree);
    free(w->summary);
    free(w);
    return failed;
}

const command command_tiles = {
    "tiles", "triangulate what memory does not hold",
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
    "pbwt",
    { tiles_options, input_options, weight_options, build_options, output_options, common_options, NULL, NULL, NULL },
    run, 0, 0, 0, NULL, 0
};
