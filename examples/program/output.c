/* output.c: outputs are checked before the work and written after it; the options for that.
   In: a job, later its mesh.  Out: files, whole or not at all; or a message that names the output. */
#include "program.h"
#include <errno.h>
#include <sys/stat.h>
#ifdef _WIN32
#include <io.h>
#define access _access
#define W_OK 2
#else
#include <unistd.h>
#endif

static const char *const colours[] = { "quality", "region", "patch", "part", "thread", "round", "order", "weight",
                                       "z", NULL };

const option inside_options[] = {
    { "--inside", NULL, "only what is inside the surface of the model", SWITCH, 0, 0, NULL },
    { "--surface", "MODEL", "the model for --inside, if it is not the input", PLAIN, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

const option look_options[] = {
    { "--title", "TEXT", "pages: default: the name of the input", PLAIN, 0, 0, NULL },
    { "--colour", "NAME", "pages: what the colours show at first: quality, region, patch, part (of the curve,\n"
      "as many as threads), thread (in whose share a point was) and round (that inserted it),\n"
      "order (of the points in the input), weight, z", CHOICE, 0, 0, colours },
    { "--eye", "X,Y,Z", "pictures and pages: direction to the viewer", DIRECTION, 0, 0, NULL },
    { "--up", "X,Y,Z", "upwards; pictures: default 0,0,1; pages: guessed", DIRECTION, 0, 0, NULL },
    { "--cut", "A,B,C,D", "pictures and pages: cut away Ax+By+Cz > D, D from -1 to 1; D = 1 cuts nothing", PLANE,
      0, 0, NULL },
    { "--cut-through", NULL, "pages: cut simplices through instead of leaving them out", SWITCH, 0, 0, NULL },
    { "--colour-outside", NULL, "pages: colours on the outside too, not only where it is cut", SWITCH, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

const option output_options[] = {
    { "-o", "FILE", "an output; - is the standard output, the report then goes to standard error", OUTPUT,
      0, 0, NULL },
    { "--format", "ENDING", "the format of outputs whose name has no known ending, such as -", PLAIN, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

const option text_options[] = {
    { "--text", NULL, "text instead of binary output", SWITCH, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

/* ---- formats ---- */

/* The word of a list with blanks between that an ending is, whatever the case of its letters; NULL: none. */
static const char *find_word(const char *list, const char *ending)
{
    static char word[8];
    size_t length, i;
    for (; *list != 0; list += length + (list[length] == ' ')) {
        length = strcspn(list, " ");
        for (i = 0; i < length && (ending[i] | 32) == list[i]; i++) {
        }
        if ((i == length || (ending[i] >= '0' && ending[i] == list[i])) && strlen(ending) == length) {
            snprintf(word, sizeof word, "%.*s", (int)length, list);
            return word;
        }
    }
    return NULL;
}

const char *ending_of(const job *j, const char *path)
{
    const char *format = text_of(j, "--format"), *found = NULL;
    const size_t length = strlen(path), packed = length > 3 && strcmp(path + length - 3, ".gz") == 0 ? 3 : 0;
    size_t at = length - packed;
    char ending[16];
    if (j->command->writes == NULL) {
        return NULL;
    }
    while (at > 0 && strchr("./\\", path[at - 1]) == NULL) {
        at--;
    }
    if (at > 0 && path[at - 1] == '.') {
        snprintf(ending, sizeof ending, "%.*s", (int)(length - packed - at), path + at);
        found = find_word(j->command->writes, ending);
        found = found != NULL && packed > 0 && strcmp(found, "pbwt") == 0 ? NULL : found;    /* is read in pieces */
    }
    if (found == NULL && format != NULL) {
        found = find_word(j->command->writes, format + (*format == '.'));
    }
    if (found == NULL && format == NULL && strcmp(path, "-") == 0 && strchr(j->command->writes, ' ') == NULL) {
        found = find_word(j->command->writes, j->command->writes);     /* the only one */
    }
    return found;
}

int writes_pages(const job *j)
{
    int i;
    for (i = 0; i < j->outputs && strcmp(ending_of(j, j->output[i]), "html") != 0; i++) {
    }
    return i < j->outputs;
}

/* ---- before the work ---- */

/* Whether two names, or a name and the standard input, "-", stand for one file. */
static int one_file(const char *a, const char *b)
{
    struct stat first, second;
    if (strcmp(a, b) == 0 && strcmp(a, "-") != 0) {
        return 1;
    }
    if (strcmp(a, "-") == 0 || stat(a, &first) != 0
        || (strcmp(b, "-") == 0 ? fstat(0, &second) : stat(b, &second)) != 0) {
        return 0;
    }
#ifdef _WIN32
    {
        char one[1024], other[1024];                 /* there st_ino is 0 */
        return _fullpath(one, a, sizeof one) != NULL && _fullpath(other, b, sizeof other) != NULL
            && _stricmp(one, other) == 0;
    }
#else
    return S_ISREG(first.st_mode) && first.st_dev == second.st_dev && first.st_ino == second.st_ino;
#endif
}

/* Whether a .poly or .smesh file has no points of its own, and takes those of the .node file beside it. */
static int lacks_points(const char *path)
{
    char line[256] = "#";
    FILE *file = fopen(path, "rb");
    while (file != NULL && line[strspn(line, " \t")] == '#' && fgets(line, sizeof line, file) != NULL) {
    }
    if (file != NULL) {
        fclose(file);
    }
    return file != NULL && atol(line) == 0;
}

/* Whether writing to the path would destroy an input: that file, or one that is read with it. */
static int destroys(const char *path, const char *input)
{
    static const char *const endings[] = { "node", "face", "edge" };
    char other[1100];
    const char *dot;
    int i, count;
    if (input == NULL) {
        return 0;
    }
    if (one_file(path, input)) {
        return 1;
    }
    dot = strrchr(input, '.');
    dot = dot != NULL && strcmp(dot, ".gz") == 0 ? strstr(input, ".ele.gz") : dot;
    if (dot == NULL || (pbwio_format_of(input) == PBWIO_POLY && !lacks_points(input))) {
        return 0;
    }
    count = strncmp(dot, ".ele", 4) == 0 ? 3 : pbwio_format_of(input) == PBWIO_POLY || strcmp(dot, ".face") == 0
         || strcmp(dot, ".edge") == 0 ? 1 : 0;
    for (i = 0; i < count; i++) {
        snprintf(other, sizeof other, "%.*s.%s", (int)(dot - input), input, endings[i]);
        if (one_file(path, other)) {
            return 1;
        }
    }
    return 0;
}

/* A folder that is there and can be written to. */
static int check_folder(const char *path)
{
    const char *slash = strrchr(path, '/');
    char folder[1100];
    struct stat info;
    snprintf(folder, sizeof folder, "%.*s", slash == NULL ? 1 : (int)(slash - path) + 1, slash == NULL ? "." : path);
    if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode)) {
        return complain("-o %s: there is no folder %s", path, folder);
    }
    if (access(folder, W_OK) != 0) {
        return complain("-o %s: %s", path, strerror(errno));
    }
    return 0;
}

/* Whether a file is a page that pbw made. */
static int is_page(const char *path)
{
    char start[256];
    FILE *file = fopen(path, "rb");
    size_t length = file == NULL ? 0 : fread(start, 1, sizeof start - 1, file);
    if (file != NULL) {
        fclose(file);
    }
    start[length] = 0;
    return strstr(start, "<meta name='generator' content='pbw'>") != NULL;
}

static int check_output(const job *j, const char *path)
{
    const char *format = text_of(j, "--format");
    struct stat info;
    if (strlen(path) > 1000) {
        return complain("-o: a name of more than 1000 characters");
    }
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode)) {
        return complain("-o %s: it is a folder", path);
    }
    if (ending_of(j, path) == NULL) {
        if (format != NULL) {
            return complain("--format %s: pbw %s writes %s", format, j->command->name, j->command->writes);
        }
        return complain("-o %s: its ending tells the format, else --format; pbw %s writes %s", path, j->command->name,
                        j->command->writes);
    }
    if (strcmp(path, "-") == 0) {
        return 0;
    }
    if (destroys(path, j->input) || destroys(path, j->second) || destroys(path, text_of(j, "--surface"))
        || destroys(path, text_of(j, "--script"))) {
        return complain("-o %s: it is an input, which would be lost; name another output", path);
    }
    if (stat(path, &info) != 0) {
        return check_folder(path);
    }
    if (path == j->named && !is_page(path)) {
        return complain("%s is there already, and is no page of pbw: -o %s replaces it, or name another", path, path);
    }
    return access(path, W_OK) != 0 ? complain("-o %s: %s", path, strerror(errno)) : 0;
}

int add_points(job *j)
{
    const char *path = NULL, *dot = NULL;
    int i;
    for (i = j->outputs - 1; i >= 0; i--) {
        const char *ending = ending_of(j, j->output[i]), *at = j->output[i] + strlen(j->output[i]);
        if (ending != NULL && strcmp(ending, "node") == 0) {
            return 0;
        }
        at -= at - j->output[i] > 7 && strcmp(at - 3, ".gz") == 0 ? 7 : at - j->output[i] > 4 ? 4 : 0;
        if (strncmp(at, ".ele", 4) == 0) {
            path = j->output[i];
            dot = at;
        }
    }
    if (path == NULL || j->outputs == MOST_OUTPUTS || strlen(path) > 1000) {
        return 0;
    }
    snprintf(j->points, sizeof j->points, "%.*s.node%s", (int)(dot - path), path, dot + 4);
    if (destroys(j->points, j->input) || destroys(j->points, text_of(j, "--surface"))) {
        return strcmp(j->command->name, "mesh") == 0 ? 0     /* whose points are those of the input */
             : complain("-o %s: its points go to %s, which is an input and would be lost; name another output", path,
                        j->points);
    }
    j->output[j->outputs++] = j->points;
    return 0;
}

int check_outputs(const job *j)
{
    const char *surface = text_of(j, "--surface");
    FILE *file;
    int i, k, status = 0;
    for (i = 0; i < j->outputs && status == 0; i++) {
        status = check_output(j, j->output[i]);
        for (k = 0; k < i && status == 0; k++) {
            if (strcmp(j->output[k], j->output[i]) == 0 || one_file(j->output[k], j->output[i])) {
                status = complain("-o %s: it is named twice", j->output[i]);
            }
        }
    }
    if (status == 0 && surface != NULL) {
        file = fopen(surface, "rb");
        if (file == NULL) {
            return complain("--surface %s: %s", surface, strerror(errno));
        }
        fclose(file);
    }
    if (status == 0 && surface == NULL && is_given(j, "--inside") && j->generate != NULL) {
        return complain("--inside: what is generated has no faces; --surface names a model that has");
    }
    return status;
}

/* ---- after the work ---- */

static void add_array(pbwview_options *view, const char *name, const uint32_t *integers, const double *real,
                      int of_points, int classes)
{
    pbwview_array *array = (pbwview_array *)(uintptr_t)(view->arrays + view->array_count++);
    memset(array, 0, sizeof *array);
    array->name = name;
    array->whole = integers;
    array->real = real;
    array->of_points = of_points;
    array->classes = classes;
}

static void fill_arrays(const job *j, uint32_t *part, uint32_t *thread, uint32_t *round)
{
    size_t parts = j->build.threads > 0 ? (size_t)j->build.threads : 8, count = j->mesh.simplex_count, i;
    for (i = 0; i < count; i++) {                    /* simplices follow the curve */
        part[i] = (uint32_t)(i * parts / count);
    }
    for (i = 0; j->build.trace != NULL && count > 0 && i < j->mesh.point_count; i++) {
        thread[i] = j->build.trace[i] == PBW_NONE ? 0 : j->build.trace[i] % 256;     /* duplicates: in no simplex */
        round[i] = j->build.trace[i] == PBW_NONE ? 0 : j->build.trace[i] / 256;
    }
}

/* Names of groups, then what they are made of; the caller frees it.  NULL: there are none, or no memory. */
static const char **name_groups(const pbwio_output *output)
{
    const size_t count = output->groups != NULL ? output->group_count : 0;
    const char **names = count > 0 ? (const char **)malloc(count * (sizeof *names + 24)) : NULL;
    size_t i;
    for (i = 0; names != NULL && i < count; i++) {
        char *text = (char *)(names + count) + 24 * i;
        snprintf(text, 24, "%lld", output->groups[i].tag);
        names[i] = output->groups[i].name != NULL ? output->groups[i].name : text;
    }
    return names;
}

/* Patches of facets at the boundary and between regions, PBW_NONE of the others; the caller frees them. */
static uint32_t *facet_patches(const pbw_mesh *mesh, const pbwio_output *output)
{
    uint32_t *patches = (uint32_t *)malloc((4 * mesh->simplex_count + 1) * sizeof *patches);
    size_t i;
    for (i = 0; patches != NULL && i < 4 * mesh->simplex_count; i++) {
        const pbw_index next = mesh->neighbors[i];
        const int inner = next != PBW_NONE && output->groups == NULL
                       && (output->regions == NULL || output->regions[next] == output->regions[i / 4]);
        patches[i] = inner ? PBW_NONE : output->patches[i];
    }
    return patches;
}

static void add_groups(const job *j, pbwview_options *view, const uint32_t *patches, const char *const *names)
{
    const pbwio_output *o = &j->write;
    const size_t first = view->array_count;
    size_t i;
    if (o->regions != NULL) {
        add_array(view, j->over != NULL ? "patch" : "region", o->regions, NULL, 0, 1);
    }
    if (patches != NULL) {
        add_array(view, "patch", patches, NULL, 0, 1);
        ((pbwview_array *)(uintptr_t)view->arrays)[view->array_count - 1].of_facets = 1;
    }
    for (i = first; i < view->array_count; i++) {
        pbwview_array *array = (pbwview_array *)(uintptr_t)(view->arrays + i);
        array->names = names;
        array->name_count = names != NULL ? o->group_count : 0;
    }
    if (view->colour == NULL && names != NULL && view->array_count > first) {
        view->colour = view->arrays[first].name;
        view->colour_outside = 1;
    }
}

static void set_up_view(const job *j, pbwview_options *view)
{
    const char *slash = j->input == NULL ? NULL : strrchr(j->input, '/');
    view->title = text_of(j, "--title") != NULL ? text_of(j, "--title") : j->generate != NULL ? j->generate
                : slash != NULL ? slash + 1 : j->input;
    view->keep = j->picture.keep;
    view->inside = j->picture.keep == NULL ? j->inside : NULL;
    view->body = j->mesh.incident == NULL;           /* not a triangulation of points */
    view->triangles = is_given(j, "--surface") || j->links != NULL || j->over != NULL ? NULL : j->cloud.triangles;
    view->heights = j->over != NULL ? j->over + 2 * j->mesh.point_count : NULL;
    view->surface = j->over != NULL;
    view->triangle_count = view->triangles != NULL ? j->cloud.triangle_count : 0;
    view->colour = text_of(j, "--colour");
    view->cut_through = is_given(j, "--cut-through");
    view->colour_outside = is_given(j, "--colour-outside");
    memcpy(view->eye, j->picture.eye, sizeof view->eye);
    memcpy(view->up, j->picture.up, sizeof view->up);
    memcpy(view->cut, j->picture.cut, sizeof view->cut);
}

pbwio_status write_mesh_page(const job *j, const char *path, pbwio_error *error)
{
    const pbw_mesh *mesh = &j->mesh;
    size_t traced = j->build.trace != NULL && mesh->simplex_count > 0 ? mesh->point_count : 0;
    uint32_t *part = (uint32_t *)malloc((mesh->simplex_count + 1) * sizeof *part);
    uint32_t *thread = (uint32_t *)malloc((traced + 1) * sizeof *thread);
    uint32_t *round = (uint32_t *)malloc((traced + 1) * sizeof *round);
    const int faceted = mesh->dim == 3 && j->write.patches != NULL && mesh->neighbors != NULL;
    uint32_t *patches = faceted ? facet_patches(mesh, &j->write) : NULL;
    const char **names = name_groups(&j->write);
    pbwview_array arrays[7];
    pbwview_options view;
    pbwio_status status = PBWIO_ERROR_MEMORY;
    char left_out[128] = "";
    memset(&view, 0, sizeof view);
    snprintf(error->text, sizeof error->text, "out of memory");
    if (mesh->duplicate_count + mesh->hidden_count > 0) {
        snprintf(left_out, sizeof left_out, "%zu duplicate and %zu hidden point%s left out", mesh->duplicate_count,
                 mesh->hidden_count, plural(mesh->duplicate_count + mesh->hidden_count));
    }
    set_up_view(j, &view);
    view.note = left_out;
    view.arrays = arrays;
    if (mesh->simplex_count > 0) {
        add_array(&view, "part", part, NULL, 0, 1);
    }
    if (traced > 0) {
        add_array(&view, "thread", thread, NULL, 1, 1);
        add_array(&view, "round", round, NULL, 1, 0);
    }
    if (mesh->weights != NULL) {
        add_array(&view, "weight", NULL, mesh->weights, 1, 0);
    }
    if (j->write.heights != NULL) {
        add_array(&view, "height", NULL, j->write.heights, 1, 0);
    }
    add_groups(j, &view, patches, names);
    if (part != NULL && thread != NULL && round != NULL && (patches != NULL || !faceted)) {
        fill_arrays(j, part, thread, round);
        status = pbwview_write(path, mesh, &view, error);
    }
    free(part);
    free(thread);
    free(round);
    free(patches);
    free(names);
    return status;
}

static pbwio_format format_of(const char *ending)
{
    char name[24];
    snprintf(name, sizeof name, "a.%s", ending);
    return pbwio_format_of(name);
}

/* One output: of a mesh, or of content if there is any. */
static pbwio_status write_one(job *j, const char *path, const char *ending, void *user, pbwio_error *error)
{
    pbwmodel_content *content = (pbwmodel_content *)user;
    if (content != NULL) {
        content->format = format_of(ending);
        return pbwmodel_write(path, content, j->write.flags, error);
    }
    if (strcmp(ending, "svg") == 0) {
        return pbwpic_write(path, &j->mesh, &j->picture, error);
    }
    if (strcmp(ending, "html") == 0) {
        return write_mesh_page(j, path, error);
    }
    if (strcmp(ending, "geojson") == 0) {
        return write_triangles(path, &j->mesh, &j->write, error);
    }
    j->write.format = format_of(ending);
    return pbwio_write(path, &j->mesh, &j->write, error);
}

/* What a file keeps of simplices of so many corners; .node .ele .face .edge .neigh are one set of files. */
static unsigned kept_by(const job *j, const char *ending, int corners)
{
    static const char family[] = "node ele face edge neigh";
    unsigned keeps = 0;
    int k;
    if (strcmp(ending, "geojson") == 0) {
        return PBWIO_REGIONS | PBWIO_NAMES | PBWIO_HEIGHTS;
    }
    if (strcmp(ending, "bin") == 0) {
        return PBWIO_WEIGHTS;
    }
    if (strcmp(ending, "svg") == 0) {                                /* a picture of regions and patches */
        return ~(unsigned)(PBWIO_MARKS | PBWIO_COLUMNS | PBWIO_HEIGHTS);
    }
    for (k = 0; k < j->outputs && find_word(family, ending) != NULL; k++) {
        const char *other = ending_of(j, j->output[k]);
        keeps |= find_word(family, other) != NULL ? pbwio_keeps(format_of(other), corners, j->write.flags) : 0;
        if (other == NULL || (k < j->written && find_word(family, other) != NULL)) {
            return ~0u;                                              /* the word is said */
        }
    }
    return keeps != 0 ? keeps : format_of(ending) == PBWIO_AUTO ? ~0u
         : pbwio_keeps(format_of(ending), corners, j->write.flags);
}

/* A word about what a format has no place for, and about groups that it calls otherwise. */
static void warn_of_drops(const job *j, const char *path)
{
    const int corners = j->mesh.simplices == j->cloud.triangles ? 3 : j->mesh.dim + 1;
    char ending[16], what[300];
    snprintf(ending, sizeof ending, "%s", ending_of(j, path) != NULL ? ending_of(j, path) : "");
    pbwio_losses(kept_by(j, ending, corners), corners, &j->mesh, &j->write, what, sizeof what);
    if (what[0] != 0) {
        warn(j, "%s: the format .%s has no place for: %s", path, ending, what);
    }
    pbwio_renamed(format_of(ending), corners, &j->mesh, &j->write, what, sizeof what);
    if (what[0] != 0) {
        warn(j, "%s: names of groups are words there: %s", path, what);
    }
}

int write_with(job *j, writer *write, void *user)
{
    pbwio_error error;
    for (; j->written < j->outputs && !interrupted; j->written++) {
        const char *path = j->output[j->written];
        double start = now();
        pbwio_status status;
        begin(j, "write", path);
        status = write(j, path, ending_of(j, path), user, &error);
        if (status != PBWIO_OK) {
            return explain_io(j, status, &error);
        }
        report_step(j, "write", now() - start, "%s", strcmp(path, "-") == 0 ? "standard output" : path);
        warn_of_drops(j, path);
    }
    return interrupted ? stopped(j) : 0;
}

typedef struct table { void (*emit)(void *user, FILE *file); void *user; } table;

static pbwio_status save_table(job *j, const char *path, const char *ending, void *user, pbwio_error *error)
{
    const table *t = (const table *)user;
    (void)ending;
    return pbwio_save(path, t->emit, t->user, &j->build, error);
}

int write_table(job *j, void (*emit)(void *user, FILE *file), void *user)
{
    table t;
    t.emit = emit;
    t.user = user;
    return write_with(j, save_table, &t);
}

int write_mesh(job *j)
{
    return write_with(j, write_one, NULL);
}

int write_model(job *j, pbwmodel_content *content)
{
    return write_with(j, write_one, content);
}
