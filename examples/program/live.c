/* live.c: pbw live.  In: points, and a script of changes.  Out: a report of each commit, and the triangulation of the
   points that are left. */
#include "program.h"
#include <errno.h>

static const option live_options[] = {
    { "--script", "FILE", "the changes, lines as above; - is the standard input", PLAIN, 0, 0, NULL },
    { "--no-hash", NULL, "leave hashes of commits out of the report: each takes a pass over the mesh", SWITCH, 0, 0,
      NULL },
    OPTION_NO_CHECK,
    OPTION_NO_ORPHANS,
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

typedef struct script {
    job *j;
    pbw_live *live;
    FILE *file;
    const char *name;
    size_t line, commits;
    size_t inserted, removed, moved;                 /* since the last commit */
    pbw_index *ids;                                  /* per number of the script the library's; PBW_NONE: removed */
    size_t count, room;                              /* of ids */
} script;

/* "changes.csv:3: why"; returns FAILURE. */
static int refuse(const script *s, const char *why)
{
    return fail(s->j, "%s:%zu: %s", s->name, s->line, why);
}

/* ---- changes ---- */

static int insert(script *s, const double *number, int count)
{
    const int dim = s->j->cloud.dim, weighted = s->j->cloud.weights != NULL;
    const double weight = count > dim ? number[dim] : 0;
    pbw_status status;
    if (count != dim && count != dim + 1) {
        return refuse(s, dim == 2 ? "insert takes x,y or x,y,weight" : "insert takes x,y,z or x,y,z,weight");
    }
    if (count > dim && !weighted) {
        return refuse(s, "a weight needs --weights");
    }
    if (s->count == s->room) {
        const size_t room = 2 * s->room + 1024;
        pbw_index *more = (pbw_index *)realloc(s->ids, room * sizeof *more);
        if (more == NULL) {
            return explain(s->j, PBW_ERROR_MEMORY);
        }
        s->ids = more;
        s->room = room;
    }
    status = pbw_live_insert(s->live, number, weighted ? &weight : NULL, 1, s->ids + s->count);
    s->count += status == PBW_OK;
    s->inserted += status == PBW_OK;
    return explain(s->j, status);
}

/* The library's number of a point; NULL after a complaint. */
static pbw_index *find(script *s, double number)
{
    char why[80];
    const int there = number >= 0 && number < (double)s->count && number <= floor(number);
    if (there && s->ids[(size_t)number] != PBW_NONE) {
        return s->ids + (size_t)number;
    }
    snprintf(why, sizeof why, "there is no point %.17g%s", number, there ? ": it was removed" : "");
    refuse(s, why);
    return NULL;
}

static int remove_point(script *s, const double *number, int count)
{
    pbw_index *id = count == 1 ? find(s, number[0]) : NULL;
    pbw_status status;
    if (id == NULL) {
        return count == 1 ? FAILURE : refuse(s, "remove takes the number of a point");
    }
    status = pbw_live_remove(s->live, id, 1);
    *id = status == PBW_OK ? PBW_NONE : *id;
    s->removed += status == PBW_OK;
    return explain(s->j, status);
}

static int move(script *s, const double *number, int count)
{
    const int right = count == 1 + s->j->cloud.dim;
    pbw_index *id = right ? find(s, number[0]) : NULL;
    pbw_status status;
    if (id == NULL) {
        return right ? FAILURE : refuse(s, s->j->cloud.dim == 2 ? "move takes the number of a point, x,y"
                                                                : "move takes the number of a point, x,y,z");
    }
    status = pbw_live_move(s->live, id, number + 1, 1);
    s->moved += status == PBW_OK;
    return explain(s->j, status);
}

/* The text for the report: the hash of the triangulation after a commit. */
static int hash_now(const script *s, char *text, size_t size)
{
    pbw_mesh mesh = { 0 };
    const pbw_status status = pbw_live_view(s->live, &mesh);
    *text = 0;
    if (status == PBW_OK) {
        snprintf(text, size, ", hash %016llx", (unsigned long long)pbw_hash(&mesh, NULL));
    } else if (status == PBW_DEGENERATE) {
        snprintf(text, size, ", the points span no simplex");
    }
    pbw_free(&mesh);
    return status == PBW_DEGENERATE ? 0 : explain(s->j, status);
}

static int commit(script *s)
{
    static const char *const ways[] = { "nothing changed", "flips", "batch", "rebuild" };
    pbw_changes changes = { PBW_WAY_NOTHING, 0, 0, 0, NULL, NULL, NULL, NULL };
    char hash[64] = "";
    const double start = now();
    const pbw_status status = pbw_live_commit(s->live, &changes);
    const double seconds = now() - start;
    int failed = status == PBW_DEGENERATE ? 0 : explain(s->j, status);
    if (!failed && !s->j->quiet && !is_given(s->j, "--no-hash")) {
        failed = hash_now(s, hash, sizeof hash);
    }
    if (!failed) {
        report_step(s->j, "commit", seconds, "%zu: %zu inserted, %zu removed, %zu moved; %s: %zu %s deleted, "
                    "%zu made%s", ++s->commits, s->inserted, s->removed, s->moved, ways[changes.way],
                    changes.deleted_count, simplices(0, changes.deleted_count), changes.made_count, hash);
    }
    s->inserted = s->removed = s->moved = 0;
    pbw_changes_free(&changes);
    return failed;
}

/* ---- the script ---- */

/* "name,1,2,3" in place: cuts the name off; returns how many numbers follow, at most 5, or -1 if some are none. */
static int split(char *text, double number[5])
{
    char *end;
    int count = 0;
    text += strcspn(text, ",");
    while (*text == ',' && count < 5) {
        *text++ = 0;
        number[count] = strtod(text, &end);
        if (end == text || !(fabs(number[count]) <= DBL_MAX)) {
            return -1;
        }
        text = end + strspn(end, " \t");
        count++;
    }
    return *text == 0 ? count : -1;
}

static int execute(script *s, char *text)
{
    nearest n = { text, NULL, 0 };
    double number[5];
    char why[160];
    const int count = split(text, number);
    int (*change)(script *, const double *, int) = strcmp(text, "insert") == 0 ? insert
        : strcmp(text, "remove") == 0 ? remove_point : strcmp(text, "move") == 0 ? move : NULL;
    if (change == NULL && strcmp(text, "commit") != 0) {
        suggest(&n, "insert");
        suggest(&n, "remove");
        suggest(&n, "move");
        suggest(&n, "commit");
        snprintf(why, sizeof why, "\"%.40s\" is none of insert, remove, move, commit%s%s", text,
                 n.name != NULL ? "; the nearest is " : "", n.name != NULL ? n.name : "");
        return refuse(s, why);
    }
    if (count < 0) {
        return refuse(s, "finite numbers with commas between are needed");
    }
    return change != NULL ? change(s, number, count) : count == 0 ? commit(s) : refuse(s, "commit takes no number");
}

static int read_script(script *s)
{
    char text[512];
    int failed = 0;
    while (!failed && !interrupted && fgets(text, sizeof text, s->file) != NULL) {
        char *from = text + strspn(text, " \t"), *end = strchr(text, '\n');
        s->line++;
        if (end == NULL && !feof(s->file)) {
            return refuse(s, "a line of more than 510 bytes");
        }
        for (end = from + strlen(from); end > from && strchr(" \t\r\n", end[-1]) != NULL; end--) {
        }
        *end = 0;
        failed = *from == 0 || *from == '#' ? 0 : execute(s, from);
    }
    if (!failed && ferror(s->file)) {
        return fail(s->j, "%s: %s", s->name, strerror(errno));
    }
    if (!failed && interrupted) {
        return stopped(s->j);
    }
    return failed || s->inserted + s->removed + s->moved == 0 ? failed : commit(s);
}

/* ---- the result ---- */

/* The arrays of a result, the points that are left in the order of the script's numbers. */
typedef struct result { double *points, *weights; pbw_index *simplices, *incident, *canonical, *rank; } result;

static void free_result(result *r)
{
    free(r->points);
    free(r->weights);
    free(r->simplices);
    free(r->incident);
    free(r->canonical);
    free(r->rank);
}

static int reserve(result *r, const pbw_mesh *mesh)
{
    const size_t count = mesh->point_count + 1, corners = (mesh->simplex_count + 1) * ((size_t)mesh->dim + 1);
    r->points = (double *)malloc(count * (size_t)mesh->dim * sizeof *r->points);
    r->weights = (double *)malloc(count * sizeof *r->weights);
    r->simplices = (pbw_index *)malloc(corners * sizeof *r->simplices);
    r->incident = (pbw_index *)malloc(count * sizeof *r->incident);
    r->canonical = (pbw_index *)malloc(count * sizeof *r->canonical);
    r->rank = (pbw_index *)malloc(count * sizeof *r->rank);
    return r->points != NULL && r->weights != NULL && r->simplices != NULL && r->incident != NULL
        && r->canonical != NULL && r->rank != NULL;
}

/* Renumbers the remaining points in the order of the script's numbers.  Of duplicates the lowest number of
   the largest weight stands for all, as in pbw mesh. */
static void renumber(const script *s, const pbw_mesh *mesh, result *r, pbw_mesh *out)
{
    const size_t dim = (size_t)mesh->dim;
    size_t i, count = 0;
    memset(r->rank, 0xff, mesh->point_count * sizeof *r->rank);      /* per number of the library that is canonical */
    for (i = 0; i < s->count; i++) {
        const pbw_index id = s->ids[i], canonical = id == PBW_NONE ? PBW_NONE : mesh->canonical[id];
        if (id == PBW_NONE) {
            continue;
        }
        memcpy(r->points + dim * count, mesh->points + dim * id, dim * sizeof *r->points);
        r->weights[count] = mesh->weights != NULL ? mesh->weights[id] : 0;
        r->incident[count] = PBW_NONE;
        if (r->rank[canonical] == PBW_NONE
            && (mesh->weights == NULL || mesh->weights[id] >= mesh->weights[canonical])) {
            r->rank[canonical] = (pbw_index)count;
            r->incident[count] = mesh->incident[canonical];
        }
        r->canonical[count++] = canonical;
    }
    for (i = 0; i < count; i++) {
        r->canonical[i] = r->rank[r->canonical[i]];
    }
    for (i = 0; i < mesh->simplex_count * (dim + 1); i++) {
        r->simplices[i] = r->rank[mesh->simplices[i]];
    }
    *out = *mesh;
    out->memory = NULL;                              /* that of mesh */
    out->point_count = count;
    out->points = r->points;
    out->weights = mesh->weights != NULL ? r->weights : NULL;
    out->simplices = r->simplices;
    out->incident = r->incident;
    out->canonical = r->canonical;
}

static int finish(script *s)
{
    job *j = s->j;
    pbw_mesh view = { 0 };
    result r = { NULL, NULL, NULL, NULL, NULL, NULL };
    const double start = now();
    const pbw_status status = pbw_live_view(s->live, &view);
    int failed = status == PBW_DEGENERATE ? 0 : explain(j, status);
    if (!failed && !reserve(&r, &view)) {
        failed = explain(j, PBW_ERROR_MEMORY);
    }
    if (!failed) {
        renumber(s, &view, &r, &j->mesh);
        report_line(j, "%zu point%s", COUNT(j->mesh.point_count));
        report_step(j, "output", now() - start, "%s", "");
        failed = is_given(j, "--no-check") ? 0 : check(j);
    }
    if (!failed) {
        describe(j);
        failed = is_given(j, "--inside") ? mark_inside(j) : 0;
        j->write.keep = j->picture.keep = j->inside;
        j->cloud.triangle_count = 0;                 /* a model's faces: its points have other numbers now */
    }
    if (!failed) {
        failed = status == PBW_DEGENERATE && j->outputs > 0 ? explain(j, status) : write_mesh(j);
    }
    memset(&j->mesh, 0, sizeof j->mesh);
    free_result(&r);
    pbw_free(&view);
    return failed;
}

/* ---- the command ---- */

static int start(script *s)
{
    job *j = s->j;
    size_t i;
    double begin;
    int failed = load(j, 1);
    failed = failed ? failed : load_surface(j);
    failed = failed ? failed : build(j);
    if (failed) {
        return failed;
    }
    free(j->build.trace);                            /* points of the script have none */
    j->build.trace = NULL;
    s->count = s->room = j->cloud.count;
    s->ids = (pbw_index *)malloc((s->count + 1) * sizeof *s->ids);
    for (i = 0; i < s->count && s->ids != NULL; i++) {
        s->ids[i] = (pbw_index)i;
    }
    begin = now();
    failed = explain(j, s->ids == NULL ? PBW_ERROR_MEMORY : pbw_live_create(&j->mesh, &j->build, &s->live));
    if (!failed) {
        report_step(j, "live", now() - begin, "%s", "");
    }
    pbw_free(&j->mesh);
    return failed;
}

static int run(job *j)
{
    script s;
    int failed;
    memset(&s, 0, sizeof s);
    s.j = j;
    s.name = text_of(j, "--script");
    if (s.name == NULL) {
        return complain("pbw live needs --script FILE; see pbw live --help");
    }
    if (strcmp(s.name, "-") == 0 && j->input != NULL && strcmp(j->input, "-") == 0) {
        return complain("points and changes cannot both be the standard input");
    }
    s.file = strcmp(s.name, "-") == 0 ? stdin : fopen(s.name, "r");
    if (s.file == NULL) {
        return complain("--script %s: %s", s.name, strerror(errno));
    }
    failed = start(&s);
    failed = failed ? failed : read_script(&s);
    failed = failed ? failed : finish(&s);
    if (s.file != stdin) {
        fclose(s.file);
    }
    pbw_live_free(s.live);
    free(s.ids);
    return failed;
}

const command command_live = {
    .name = "live",
    .summary = "insert, remove and move points by a script",
    .usage =
    "usage: pbw live [options] points --script changes.csv [-o output]...\n"
    "\n"
    "Triangulates the points, then inserts, removes and moves some.  After each commit the triangulation is that\n"
    "which pbw mesh makes of the points there are.  A script has lines\n"
    "  insert,X,Y[,Z][,WEIGHT]      a weight goes with --weights, and is 0 if it is not given\n"
    "  remove,NUMBER\n"
    "  move,NUMBER,X,Y[,Z]\n"
    "  commit                       carries out the lines since the last one; there is one more at the end\n"
    "and empty ones, and comments behind #.  Numbers of points count from 0, in the file, then in insertions; they\n"
    "are never given again.  In outputs the points that are left are in that order.\n"
    "\n"
    "input:   as for pbw mesh\n"
    "output:  as of pbw mesh\n"
    "\n",
    .writes = "vtu msh msh2 mesh inp su2 node ele neigh face edge obj "
              "ply stl off xyz csv txt pts asc dat tsv svg html",
    .options = { live_options, inside_options, look_options, input_options, weight_options, build_options,
                 output_options, text_options, common_options, NULL },
    .run = run,
    .may_be_flat = 1,
};
