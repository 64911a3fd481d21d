/* campaign.c: the pbw program among faults: damaged files, allocations that fail, full disks, closed streams, memory
   limits.  Whatever happens, a run ends by itself, with status 0 and the right output, or with another one, a message
   and no output; no file of its own is left.
       campaign PBW FOLDER --count N        PBW: linked with campaign_memory.c; N damaged files */
#if defined(__linux__) || defined(__APPLE__)
#define _GNU_SOURCE
#endif
#include "inputs.h"
#include "test.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* A run: words, with IN and OUT for the files; what it lacks. */
typedef struct run {
    const char *command, *in, *out;
    long fail_at;                               /* the allocation that fails; 0: none */
    int closed;                                 /* bit i: stream i */
    long most_bytes;                            /* of a file that is written; 0: any */
    int counts;                                 /* writes its number of allocations to "requests" */
} run;

static const char *pbw;
static char said[4096];                         /* the last run's report */

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void in_child(const run *r, char **word)
{
    const struct rlimit files = { (rlim_t)r->most_bytes, (rlim_t)r->most_bytes }, cpu = { 60, 60 };
    char text[32];
    int i, report = open("said", O_CREAT | O_TRUNC | O_WRONLY, 0600), none = open("/dev/null", O_RDONLY);
    dup2(none, 0);
    dup2(report, 1);
    dup2(report, 2);
    close(report);
    close(none);
    for (i = 0; i < 3; i++) {
        if (r->closed >> i & 1) {
            close(i);
        }
    }
    setrlimit(RLIMIT_CPU, &cpu);                /* a run that does not end is killed, which is a fault */
    if (r->most_bytes > 0) {
        signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &files);
    }
    if (r->fail_at > 0) {
        snprintf(text, sizeof text, "%ld", r->fail_at);
        setenv("FAIL_AT", text, 1);
    }
    if (r->counts) {
        setenv("COUNT_TO", "requests", 1);
    }
    execv(pbw, word);
    _exit(100);
}

static void read_report(void)
{
    FILE *file = fopen("said", "rb");
    size_t n = 0;
    if (file != NULL) {
        n = fread(said, 1, sizeof said - 1, file);
        fclose(file);
    }
    said[n] = 0;
}

/* Returns the exit status; -1 for a signal, -2 for what a sanitizer found. */
static int go(const run *r)
{
    static char text[512];
    static char *word[40];
    int n = 1, state = 0;
    pid_t child;
    char *at;
    snprintf(text, sizeof text, "%s", r->command);
    word[0] = (char *)(uintptr_t)pbw;
    for (at = strtok(text, " "); at != NULL && n < 38; at = strtok(NULL, " ")) {
        word[n++] = strcmp(at, "IN") == 0 ? (char *)(uintptr_t)r->in
                  : strcmp(at, "OUT") == 0 ? (char *)(uintptr_t)r->out : at;
    }
    word[n] = NULL;
    fflush(stdout);
    child = fork();
    if (child == 0) {
        in_child(r, word);
    }
    if (child < 0 || waitpid(child, &state, 0) != child) {
        return -1;
    }
    read_report();
    return !WIFEXITED(state) ? -1 : WEXITSTATUS(state) == 99 ? -2 : WEXITSTATUS(state);
}

static char *load(const char *name, size_t *size)
{
    FILE *file = fopen(name, "rb");
    char *data = NULL;
    struct stat info;
    *size = 0;
    if (file != NULL && fstat(fileno(file), &info) == 0) {
        data = (char *)malloc((size_t)info.st_size + 1);
        *size = data != NULL ? fread(data, 1, (size_t)info.st_size, file) : 0;
    }
    if (file != NULL) {
        fclose(file);
    }
    return data;
}

static void store(const char *name, const char *data, size_t size)
{
    FILE *file = fopen(name, "wb");
    if (file == NULL || fwrite(data, 1, size, file) != size || fclose(file) != 0) {
        abort();
    }
}

/* Whether a file that only a run in progress may have is there.  Tiles keep theirs, to go on from there. */
static int litter(const run *r)
{
    DIR *folder = opendir(".");
    struct dirent *entry;
    int found = 0;
    while (folder != NULL && (entry = readdir(folder)) != NULL) {
        found |= strstr(entry->d_name, ".part") != NULL && strstr(r->command, "tiles") == NULL;
    }
    if (folder != NULL) {
        closedir(folder);
    }
    return found;
}

static void judge(const run *r, int status)
{
    const int there = r->out != NULL && access(r->out, F_OK) == 0;
    const int fails = status != 0 && (r->closed & 2) == 0;           /* else, perhaps, only the report */
    if (!CHECK(status >= 0 && status <= 3 && !(fails && there) && !litter(r))) {
        test_say("status %d, output %d, of pbw %s with %s, allocation %ld, closed %d, files up to %ld bytes", status,
                 there, r->command, r->in, r->fail_at, r->closed, r->most_bytes);
        test_say("%.400s", said);
        store("failed", said, strlen(said));
    }
}

/* ---- damaged files */

static const char *const formats[] = { "m.csv", "m.obj", "m.stl", "m.ply", "m.off", "m.vtu", "m.msh", "m.msh2",
    "m.mesh", "m.node", "m.inp", "m.su2", "p.csv", "p.obj", "p.vtu", "p.geojson", "m.xyz", "m.pbwt" };
static const char *const commands[] = { "mesh IN -o OUT", "check IN", "convert IN -o OUT", "plane IN -o OUT",
    "cells IN -o OUT", "solid IN --seconds 2 -o OUT", "sample IN --count 50 -o OUT", "improve IN --seconds 2 -o OUT",
    "locate m.csv IN", "nearest m.csv IN", "mesh IN --weights 3 -o OUT", "view IN -o OUT" };
static const char *const outputs[] = { "out.vtu", "out.csv", "out.obj", "out.msh", "out.mesh", "out.ply" };
#define COUNT_OF(array) (sizeof array / sizeof *array)

static size_t damage(uint64_t *state, char *data, size_t size)
{
    const size_t at = input_below(state, (uint32_t)size), length = 1 + input_below(state, 40);
    const size_t cut = length < size - at ? length : size - at;
    switch (input_below(state, 5)) {
    case 0: data[at] = (char)(data[at] ^ 1 << input_below(state, 8)); return size;
    case 1: memset(data + at, (int)input_below(state, 256), cut); return size;
    case 2: memmove(data + at, data + at + cut, size - at - cut); return size - cut;
    case 3: return at + 1;
    default: data[at] = "0123456789.-e \n,"[input_below(state, 16)]; return size;
    }
}

static void test_damage(void)
{
    const double start = seconds();
    uint64_t state = test_seed;
    long n, done = 0;
    if (!test_begin("damaged files: %ld", test_count)) {
        return;
    }
    for (n = 0; n < test_count; n++) {
        const char *name = formats[input_below(&state, COUNT_OF(formats))];
        char in[32];
        size_t size, changes = 1 + input_below(&state, 3);
        char *data = load(name, &size);
        run r;
        int status;
        memset(&r, 0, sizeof r);
        if (!CHECK(data != NULL && size > 0)) {
            test_say("no %s", name);
            break;
        }
        while (changes-- > 0) {
            size = damage(&state, data, size);
        }
        snprintf(in, sizeof in, "in%s", strrchr(name, '.'));
        store(in, data, size);
        r.in = in;
        r.command = strstr(name, "pbwt") != NULL ? "check IN" : commands[input_below(&state, COUNT_OF(commands))];
        r.out = strstr(r.command, "OUT") == NULL ? NULL : strstr(r.command, "view") != NULL ? "out.html"
              : outputs[input_below(&state, COUNT_OF(outputs))];
        status = go(&r);
        judge(&r, status);
        done += status == 0;
        if (r.out != NULL) {
            unlink(r.out);
        }
        unlink(in);
        free(data);
    }
    test_say("%ld runs, %ld of them with status 0, %.0f s", n, done, seconds() - start);
    test_end();
}

/* ---- faults: each command with a sound file, first without a fault */

static const run sound[] = {
    { "mesh IN -o OUT", "m.csv", "out.vtu", 0, 0, 0, 0 }, { "mesh IN -o OUT", "m.vtu", "out.msh", 0, 0, 0, 0 },
    { "check IN", "m.vtu", NULL, 0, 0, 0, 0 }, { "convert IN -o OUT", "m.msh", "out.mesh", 0, 0, 0, 0 },
    { "plane IN -o OUT", "ring.geojson", "out.vtu", 0, 0, 0, 0 },
    { "cells IN -o OUT", "p.csv", "out.vtu", 0, 0, 0, 0 },
    { "solid IN --size 0.5 -o OUT", "closed.obj", "out.mesh", 0, 0, 0, 0 },
    { "sample IN --count 40 -o OUT", "closed.obj", "out.csv", 0, 0, 0, 0 },
    { "improve IN -o OUT", "m.mesh", "out.vtu", 0, 0, 0, 0 }, { "locate m.csv IN", "m.xyz", NULL, 0, 0, 0, 0 },
    { "view IN -o OUT", "m.vtu", "out.html", 0, 0, 0, 0 },
    { "tiles IN --tiles 2 -o OUT", "m.csv", "out.pbwt", 0, 0, 0, 0 }
};

/* One run with a fault: status 0 only with the output of a run without one. */
static int with_fault(const run *r, const char *right, size_t right_size)
{
    const int status = go(r);
    size_t size = 0;
    char *data = r->out != NULL ? load(r->out, &size) : NULL;
    judge(r, status);
    CHECK(data == NULL ? status != 0 || r->out == NULL : size == right_size && memcmp(data, right, size) == 0);
    free(data);
    if (r->out != NULL) {
        unlink(r->out);
    }
    return status;
}

static void test_run(const run *given)
{
    const double start = seconds();
    run r = *given;
    long k, requests = 0, runs = 0, refused = 0, step;
    size_t size = 0;
    char *right = NULL;
    FILE *file;
    if (!test_begin("faults: pbw %s with %s", r.command, r.in)) {
        return;
    }
    r.counts = 1;
    if (!CHECK_EQUAL(go(&r), 0)) {
        test_say("%.400s", said);
    }
    r.counts = 0;
    file = fopen("requests", "r");
    CHECK(file != NULL && fscanf(file, "%ld", &requests) == 1 && requests > 0);
    if (file != NULL) {
        fclose(file);
    }
    if (r.out != NULL) {
        right = load(r.out, &size);
        unlink(r.out);
    }
    step = requests / (test_count < 1000 ? 100 : test_count / 5) + 1;        /* of many allocations only some */
    for (k = 1; k <= requests; k += k < 50 ? 1 : step, runs++) {
        r.fail_at = k;
        refused += with_fault(&r, right, size) != 0;
    }
    r.fail_at = 0;
    CHECK(refused > 0);
    for (r.closed = 1; r.closed < 8; r.closed++, runs++) {
        (void)with_fault(&r, right, size);
    }
    r.closed = 0;
    for (k = 0; k < 10 && r.out != NULL; k++, runs++) {                       /* full after each tenth of it */
        r.most_bytes = (long)(size * (size_t)k / 10) + 1;
        CHECK(with_fault(&r, right, size) != 0);
    }
    r.most_bytes = 0;
    CHECK_EQUAL(with_fault(&r, right, size), 0);                     /* also where the failed runs left something */
    test_say("pbw %s: %ld runs, %ld of %ld allocations failed, %.0f s", r.command, runs, refused, requests,
             seconds() - start);
    free(right);
    test_end();
}

/* ---- limits of memory */

static void test_limits(const run *given)
{
    static const char *const limited[] = { "mesh ", "plane ", "cells ", "locate ", "tiles " };
    char command[128], *right = NULL;
    run r = *given;
    long k, failed = 0;
    size_t size = 0, i;
    for (i = 0; i < COUNT_OF(limited) && strncmp(r.command, limited[i], strlen(limited[i])) != 0; i++) {
    }
    if (i == COUNT_OF(limited) || !test_begin("memory limits: pbw %s with %s", r.command, r.in)) {
        return;
    }
    CHECK_EQUAL(go(&r), 0);
    if (r.out != NULL) {
        right = load(r.out, &size);
        unlink(r.out);
    }
    for (k = 1; k <= 30; k++) {
        snprintf(command, sizeof command, "%s --memory-limit %ld", given->command, 2000L << k / 2);
        r.command = command;
        failed += with_fault(&r, right, size) != 0;
    }
    test_say("pbw %s: %ld of 30 limits suffice", given->command, 30 - failed);
    CHECK(failed > 0 && failed < 30);
    free(right);
    test_end();
}

int main(int argc, char **argv)
{
    size_t i;
    if (argc < 3 || chdir(argv[2]) != 0) {
        fprintf(stderr, "usage: campaign PBW FOLDER [--count N]\n");
        return 2;
    }
    pbw = argv[1];
    test_start(argc - 2, argv + 2, 1000);
    test_damage();
    for (i = 0; i < COUNT_OF(sound); i++) {
        test_run(sound + i);
    }
    for (i = 0; i < COUNT_OF(sound); i++) {
        test_limits(sound + i);
    }
    return test_finish();
}
