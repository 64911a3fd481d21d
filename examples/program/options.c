/* options.c: the command line.  In: arguments, the tables of commands and options.  Out: a job, or a message that
   names the option, its value and what is allowed. */
#include "program.h"
#include <stdarg.h>

#define ADDRESS(name) &command_##name,
static const command *const commands[] = { COMMANDS(ADDRESS) NULL };
#undef ADDRESS

const option common_options[] = {
    { "--quiet", NULL, "print errors only", SWITCH, 0, 0, NULL },
    { NULL, NULL, NULL, SWITCH, 0, 0, NULL }
};

int complain(const char *format, ...)
{
    va_list list;
    fputs("pbw: ", stderr);
    va_start(list, format);
    vfprintf(stderr, format, list);
    va_end(list);
    fputc('\n', stderr);
    return USAGE;
}

/* ---- names ---- */

/* The fewest letters to insert, delete, replace or swap that make one word of the other; of 30 letters at most. */
static int distance(const char *a, const char *b)
{
    int row[3][32], m = (int)strlen(a), n = (int)strlen(b), i, k, best;
    if (m > 30 || n > 30) {
        return 99;
    }
    for (k = 0; k <= n; k++) {
        row[0][k] = k;
    }
    for (i = 1; i <= m; i++) {
        int *now_row = row[i % 3], *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];
        now_row[0] = i;
        for (k = 1; k <= n; k++) {
            best = last[k - 1] + (a[i - 1] != b[k - 1]);
            best = last[k] + 1 < best ? last[k] + 1 : best;
            best = now_row[k - 1] + 1 < best ? now_row[k - 1] + 1 : best;
            if (i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1] && before[k - 2] + 1 < best) {
                best = before[k - 2] + 1;
            }
            now_row[k] = best;
        }
    }
    return row[m % 3][n];
}

void suggest(nearest *n, const char *name)
{
    int d = distance(n->word, name);
    if (d <= (int)strlen(name) / 2 && (n->name == NULL || d < n->distance)) {
        n->name = name;
        n->distance = d;
    }
}

static const command *find_command(const char *name)
{
    int i;
    for (i = 0; commands[i] != NULL && strcmp(commands[i]->name, name) != 0; i++) {
    }
    return commands[i];
}

/* The option of that name, of which the first `length` letters count; other spellings are here. */
static const option *find_option(const command *c, const char *name, size_t length)
{
    static const char *const others[][2] = { { "--output", "-o" }, { "--color", "--colour" },
                                             { "--color-outside", "--colour-outside" } };
    const option *o;
    size_t g;
    for (g = 0; g < sizeof others / sizeof *others; g++) {
        if (strlen(others[g][0]) == length && strncmp(others[g][0], name, length) == 0) {
            name = others[g][1];
            length = strlen(name);
        }
    }
    for (g = 0; c->options[g] != NULL; g++) {
        for (o = c->options[g]; o->name != NULL; o++) {
            if (strlen(o->name) == length && strncmp(o->name, name, length) == 0) {
                return o;
            }
        }
    }
    return NULL;
}

static int unknown_command(const char *name)
{
    nearest n = { name, NULL, 0 };
    int i;
    for (i = 0; commands[i] != NULL; i++) {
        suggest(&n, commands[i]->name);
    }
    if (n.name != NULL) {
        return complain("\"%s\" is neither a command nor a file; the nearest command is %s", name, n.name);
    }
    return complain("\"%s\" is neither a command nor a file; pbw help lists the commands", name);
}

static int unknown_option(const command *c, const char *text)
{
    char name[40];
    nearest n = { name, NULL, 0 };
    const option *o;
    int i;
    snprintf(name, sizeof name, "%.*s", (int)strcspn(text, "="), text);
    for (i = 0; c->options[i] != NULL; i++) {
        for (o = c->options[i]; o->name != NULL; o++) {
            if (strlen(o->name) > 2) {                               /* any letter is near to -o */
                suggest(&n, o->name);
            }
        }
    }
    for (i = 0; commands[i] != NULL; i++) {
        if (find_option(commands[i], name, strlen(name)) != NULL) {
            return complain("pbw %s has no option %s, pbw %s has", c->name, name, commands[i]->name);
        }
    }
    if (n.name != NULL) {
        return complain("pbw %s has no option %s; the nearest is %s", c->name, name, n.name);
    }
    return complain("pbw %s has no option %s; see pbw %s --help", c->name, name, c->name);
}

/* ---- help ---- */

/* A text whose further lines start at the column of the first. */
static void print_indented(const char *text, int column)
{
    for (; *text != 0; text++) {
        putchar(*text);
        if (*text == '\n') {
            printf("%*s", column, "");
        }
    }
    putchar('\n');
}

static void print_option(const option *o)
{
    char head[64];
    snprintf(head, sizeof head, "%s%s%s", o->name, o->value != NULL ? " " : "", o->value != NULL ? o->value : "");
    printf("  %-21s ", head);
    if (strlen(head) > 21) {
        printf("\n%24s", "");
    }
    print_indented(o->help, 24);
}

static void list_commands(void)
{
    int i;
    for (i = 0; commands[i] != NULL; i++) {
        printf("  pbw %-8s --help   %s\n", commands[i]->name, commands[i]->summary);
    }
}

void print_help(const command *c, int all)
{
    const option *o;
    int i;
    fputs(c->usage, stdout);
    for (i = 0; c->options[i] != NULL; i++) {
        for (o = c->options[i]; o->name != NULL; o++) {
            print_option(o);
        }
    }
    puts("  -h, --help, --version");
    if (all) {
        puts("\ncommands:");
        list_commands();
    }
    puts("\nexit status: 0 done, 1 failure, 2 wrong usage\n\nexamples:");
    for (i = 0; i < EXAMPLES; i++) {
        printf("  %s\n", example_of(c, i));
    }
}

/* ---- values ---- */

static int numbers(const char *text, int count, double *out)         /* "1,2,3" */
{
    char *end;
    int i;
    for (i = 0; i < count; i++, text = end + 1) {
        out[i] = strtod(text, &end);
        if (end == text || !(fabs(out[i]) <= DBL_MAX) || *end != (i + 1 < count ? ',' : 0)) {
            return 0;
        }
    }
    return 1;
}

/* With K, M, G, T or KiB ..., powers of 1024, or KB ..., powers of 1000; -1: it is no such number. */
static double whole(const char *text)
{
    static const char units[] = "KMGT";
    char *end;
    const char *unit;
    double x = strtod(text, &end);
    unit = *end != 0 ? strchr(units, *end >= 'a' && *end <= 'z' ? *end - 32 : *end) : NULL;
    if (unit != NULL) {
        const int decimal = end[1] == 'B';
        x *= pow(decimal ? 1000 : 1024, (double)(unit - units + 1));
        end += decimal ? 2 : end[1] == 'i' && end[2] == 'B' ? 3 : 1;
    }
    return end != text && *end == 0 && x >= 0 && x <= DBL_MAX && x <= floor(x) ? x : -1;
}

static int find(const char *const *names, const char *name)          /* -1: it is not there */
{
    int i;
    for (i = 0; names[i] != NULL; i++) {
        if (strcmp(names[i], name) == 0) {
            return i;
        }
    }
    return -1;
}

static int is_allowed(const option *o, const char *value, const char *more)
{
    double x[9], n;
    int k;
    switch (o->kind) {
        case WHOLE: n = whole(value); return n >= o->least && n <= o->most;
        case BYTES: n = whole(value); return n >= 1 && n <= (double)((size_t)-1 / 2);
        case POSITIVE: return numbers(value, 1, x) && x[0] > 0 && (o->most <= 0 || x[0] <= o->most);
        case FORMULA: return !numbers(value, 1, x) || x[0] > 0;
        case DIRECTION: return numbers(value, 3, x) && fabs(x[0]) + fabs(x[1]) + fabs(x[2]) > 0;
        case PLANE: return numbers(value, 4, x) && fabs(x[0]) + fabs(x[1]) + fabs(x[2]) > 0 && fabs(x[3]) <= 1;
        case BOX:
            k = numbers(value, 4, x) ? 2 : numbers(value, 6, x) ? 3 : 0;
            return k > 0 && x[0] < x[k] && x[1] < x[k + 1] && (k == 2 || x[2] < x[5]);
        case LATTICE: return numbers(value, 4, x) || numbers(value, 9, x);
        case AXES: return *value != 0 && strspn(value, "xyz") == strlen(value) && strlen(value) <= 3;
        case CHOICE: return find(o->choices, value) >= 0;
        case GENERATE:
            n = more != NULL ? whole(more) : -1;
            return find(o->choices, value) >= 0 && n >= o->least && n <= o->most;
        default: return 1;
    }
}

/* "--threads 1000: a whole number from 0 to 256 is needed". */
static int refuse(const option *o, const char *value, const char *more)
{
    char names[512] = "";
    nearest n = { value != NULL ? value : "", NULL, 0 };
    int i;
    for (i = 0; o->choices != NULL && o->choices[i] != NULL; i++) {
        snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", i > 0 ? ", " : "", o->choices[i]);
        suggest(&n, o->choices[i]);
    }
    fprintf(stderr, "pbw: %s", o->name);
    if (value != NULL) {
        fprintf(stderr, " %s", value);
    }
    if (o->kind == GENERATE && more != NULL && find(o->choices, n.word) >= 0) {
        fprintf(stderr, " %s", more);
    }
    switch (value != NULL || o->kind != PLAIN ? o->kind : SWITCH) {
        case WHOLE: fprintf(stderr, ": a whole number from %.0f to %.0f is needed", o->least, o->most); break;
        case BYTES: fputs(": a number of bytes such as 500M or 4G is needed", stderr); break;
        case POSITIVE:
            fputs(": a number above 0", stderr);
            if (o->most > 0) {
                fprintf(stderr, " and up to %g", o->most);
            }
            fputs(" is needed", stderr);
            break;
        case FORMULA: fputs(": a number above 0, a formula or a column is needed", stderr); break;
        case DIRECTION: fputs(": a direction X,Y,Z other than 0,0,0 is needed", stderr); break;
        case PLANE:
            fputs(": A,B,C,D is needed, a direction A,B,C other than 0,0,0 and D from -1 to 1", stderr);
            break;
        case BOX: fputs(": the low corner and the high corner are needed, X,Y,X,Y or X,Y,Z,X,Y,Z", stderr); break;
        case LATTICE: fputs(": vectors are needed, 4 numbers in 2D or 9 in 3D", stderr); break;
        case AXES: fputs(": some of the letters x, y, z are needed", stderr); break;
        case GENERATE:
            if (find(o->choices, n.word) >= 0) {
                fprintf(stderr, ": a count from %.0f to %.0f is needed", o->least, o->most);
                break;
            }                                                        /* fall through */
        case CHOICE:
            fprintf(stderr, ": one of %s is needed", names);
            if (n.name != NULL) {
                fprintf(stderr, "; the nearest is %s", n.name);
            }
            break;
        default: fprintf(stderr, ": %s is needed", o->value);
    }
    fputc('\n', stderr);
    return USAGE;
}

/* ---- lookups ---- */

static const given *find_given(const job *j, const char *name)        /* the last counts */
{
    int i;
    for (i = j->given_count - 1; i >= 0; i--) {
        if (strcmp(j->given[i].option->name, name) == 0) {
            return j->given + i;
        }
    }
    return NULL;
}

int is_given(const job *j, const char *name)
{
    return find_given(j, name) != NULL;
}

const char *text_of(const job *j, const char *name)
{
    const given *g = find_given(j, name);
    return g != NULL ? g->value : NULL;
}

double number_of(const job *j, const char *name, double otherwise)
{
    const given *g = find_given(j, name);
    return g == NULL ? otherwise : g->option->kind == POSITIVE ? strtod(g->value, NULL)
         : whole(g->option->kind == GENERATE ? g->more : g->value);
}

int choice_of(const job *j, const char *name)
{
    const given *g = find_given(j, name);
    return g != NULL ? find(g->option->choices, g->value) : -1;
}

int vector_of(const job *j, const char *name, int count, double *out)
{
    const given *g = find_given(j, name);
    return g != NULL && numbers(g->value, count, out);
}

/* ---- parsing ---- */

static int add_output(job *j, const char *path)
{
    if (j->outputs == MOST_OUTPUTS) {
        return complain("-o %s: at most %d outputs are possible", path, MOST_OUTPUTS);
    }
    j->output[j->outputs++] = path;
    return 0;
}

/* The option at argv[i], its value in the next argument, behind "=", or behind a name of one letter; returns how many
   arguments it takes, 0 after a complaint. */
static int take_option(job *j, int argc, char **argv, int i)
{
    const size_t length = argv[i][1] == '-' ? strcspn(argv[i], "=") : 2;
    const option *o = find_option(j->command, argv[i], length);
    const int joined = argv[i][length] != 0, at = i + !joined;
    const char *value = joined ? argv[i] + length + (argv[i][length] == '=') : at < argc ? argv[at] : NULL;
    const char *more = at + 1 < argc ? argv[at + 1] : NULL;
    given *g = j->given + j->given_count++;
    if (o == NULL) {
        unknown_option(j->command, argv[i]);
        return 0;
    }
    if (o->kind == SWITCH && joined) {
        complain("%s takes no value", o->name);
        return 0;
    }
    if (o->kind != SWITCH && (value == NULL || !is_allowed(o, value, more))) {
        refuse(o, value, more);
        return 0;
    }
    g->option = o;
    g->value = o->kind != SWITCH ? value : NULL;
    g->more = more;
    if (o->kind == OUTPUT && add_output(j, value) != 0) {
        return 0;
    }
    return (o->kind == SWITCH ? 1 : o->kind == GENERATE ? 3 : 2) - joined;
}

static int take_file(job *j, const char *path)
{
    if (j->command->outputs_follow && (j->input != NULL || is_given(j, "--generate"))) {
        return add_output(j, path);
    }
    if (j->input != NULL && j->command->second != NULL && j->second == NULL) {
        j->second = path;
        return 0;
    }
    if (j->input != NULL) {
        return complain("more than %s: %s and %s", j->second != NULL ? "two inputs" : "one input",
                        j->second != NULL ? j->second : j->input, path);
    }
    j->input = path;
    return 0;
}

/* An output beside the input, with the ending that the command writes. */
static void name_output(job *j)
{
    const char *name = j->generate != NULL ? j->generate : strcmp(j->input, "-") == 0 ? "pbw" : j->input;
    const char *slash = strrchr(name, '/'), *dot = strrchr(name, '.');
    int length = dot != NULL && (slash == NULL || dot > slash + 1) ? (int)(dot - name) : (int)strlen(name);
    snprintf(j->named, sizeof j->named, "%.*s.%s", length > 1000 ? 1000 : length, name, j->command->writes);
    j->output[j->outputs++] = j->named;
}

/* Settings that many commands share. */
static void fill(job *j)
{
    j->quiet = is_given(j, "--quiet");
    j->generate = text_of(j, "--generate");
    j->count = (size_t)number_of(j, "--generate", 0);
    j->read.dim = (int)number_of(j, "--dim", 0);
    j->read.columns = text_of(j, "--columns");
    j->read.weight = text_of(j, "--weights");
    j->read.keep = text_of(j, "--keep");
    j->read.flags = is_given(j, "--decimal-comma") ? PBWIO_DECIMAL_COMMA : 0;
    j->read.build = &j->build;
    j->build.threads = (int)number_of(j, "--threads", 0);
    j->build.memory_limit = (size_t)number_of(j, "--memory-limit", 0);
    j->build.flags = is_given(j, "--any-order") ? PBW_ANY_ORDER : 0;
    j->write.flags = (is_given(j, "--no-orphans") ? PBWIO_NO_ORPHANS : 0) | (is_given(j, "--text") ? PBWIO_TEXT : 0);
    vector_of(j, "--eye", 3, j->picture.eye);
    vector_of(j, "--up", 3, j->picture.up);
    vector_of(j, "--cut", 4, j->picture.cut);
}

/* Returns 0 or USAGE.  Where points are generated, the only file is the second input. */
static int check_inputs(job *j)
{
    const command *c = j->command;
    if (c->second != NULL && j->generate != NULL && j->second == NULL) {
        j->second = j->input;
        j->input = NULL;
    }
    if (j->input != NULL && j->generate != NULL) {
        return complain("an input and --generate exclude each other: %s", j->input);
    }
    if (j->input == NULL && j->generate == NULL && !c->may_lack_input) {
        return complain("an input is needed; see pbw %s --help", c->name);
    }
    if (c->second != NULL && j->second == NULL) {
        return complain("a file of %s is needed after that of points; see pbw %s --help", c->second, c->name);
    }
    if (j->input != NULL && j->second != NULL && strcmp(j->input, "-") == 0 && strcmp(j->second, "-") == 0) {
        return complain("points and %s cannot both be the standard input", c->second);
    }
    return 0;
}

/* Whether somebody may have meant that for a command: no such file, and no character that names of files have. */
static int could_be_command(const char *name)
{
    FILE *file = name[0] != '-' && strpbrk(name, "./\\") == NULL ? fopen(name, "rb") : stdin;
    if (file != NULL && file != stdin) {
        fclose(file);
    }
    return file == NULL;
}

static int help_or_version(int argc, char **argv, const command *c, int all)
{
    int i;
    if (argc < 2) {
        puts("pbw: meshes of points, plane domains and solids; cells; files and pages\n\n"
             "  pbw model.obj -o model.html      triangulates points and shows them\n");
        list_commands();
        return 1;
    }
    if (argc > 1 && strcmp(argv[1], "help") == 0 && could_be_command("help")) {
        if (argc > 2 && print_manual(argv[2], commands)) {
            return 1;
        }
        if (argc > 2 && find_command(argv[2]) == NULL) {
            return 1 + unknown_command(argv[2]);
        }
        print_help(argc > 2 ? find_command(argv[2]) : &command_mesh, argc <= 2);
        return 1;
    }
    for (i = 1; i < argc && strcmp(argv[i], "--") != 0; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            print_help(c, all);
            return 1;
        }
        if (strcmp(argv[i], "--version") == 0) {
            printf("pbw %d.%d.%d\n", PBW_VERSION_MAJOR, PBW_VERSION_MINOR, PBW_VERSION_PATCH);
            return 1;
        }
    }
    return 0;
}

int parse(int argc, char **argv, job *j)
{
    const command *named = argc > 1 ? find_command(argv[1]) : NULL;
    int i = named != NULL ? 2 : 1, taken, status, files_only = 0;
    j->command = named != NULL ? named : &command_mesh;
    status = help_or_version(argc, argv, j->command, named == NULL);
    if (status != 0) {
        return status;
    }
    if (named == NULL && argc > 1 && could_be_command(argv[1])) {
        return 1 + unknown_command(argv[1]);
    }
    j->given = (given *)calloc((size_t)argc, sizeof *j->given);
    if (j->given == NULL) {
        return 1 + complain("out of memory");
    }
    for (; i < argc; i += taken) {
        taken = 1;
        if (!files_only && strcmp(argv[i], "--") == 0) {
            files_only = 1;
        } else if (!files_only && argv[i][0] == '-' && argv[i][1] != 0) {
            taken = take_option(j, argc, argv, i);
        } else {
            taken = take_file(j, argv[i]) == 0;
        }
        if (taken == 0) {
            return 1 + USAGE;
        }
    }
    fill(j);
    if (check_inputs(j) != 0) {
        return 1 + USAGE;
    }
    if (j->command->names_output && j->outputs == 0) {
        name_output(j);
    }
    return 0;
}
