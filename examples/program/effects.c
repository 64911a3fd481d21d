/* effects.c: refuses options that would have no effect, or exclude each other, before the work. */
#include "program.h"

/* What `needs` and `excludes` hold, with blanks between: --name: that option; .ending: an output of that format;
   *.ending: an input of such a name. */
typedef struct rule {
    const char *commands;                            /* with blanks between; NULL: all that have the option */
    const option *group;                             /* NULL, or only commands that have this group of options */
    int one_input;                                   /* only commands that read no second input */
    const char *option;
    const char *needs;                               /* one of these; NULL: nothing */
    const char *excludes;                            /* none of these; NULL: anything may be there */
} rule;

#define REFINING "--angle --area --size --conforming"

static const rule rules[] = {
    { .group = input_options, .option = "--seed", .needs = "--generate" },
    { .group = input_options, .one_input = 1, .option = "--columns", .excludes = "--generate *.pbwt *.bin" },
    { .group = input_options, .one_input = 1, .option = "--decimal-comma", .excludes = "--generate *.pbwt *.bin" },
    { .option = "--keep", .excludes = "--generate *.pbwt *.bin" },
    { .option = "--weights", .excludes = "--generate *.pbwt" },
    { .commands = "check convert hash", .option = "--dim", .excludes = "*.pbwt" },
    { .option = "--surface", .needs = "--inside" },
    { .option = "--title", .needs = ".html" },
    { .option = "--colour", .needs = ".html" },
    { .option = "--cut-through", .needs = ".html" },
    { .option = "--colour-outside", .needs = ".html" },
    { .option = "--eye", .needs = ".html .svg" },
    { .option = "--up", .needs = ".html .svg" },
    { .option = "--cut", .needs = ".html .svg" },
    { .option = "--text", .needs = ".vtu .msh .ply .stl" },
    { .option = "--no-orphans",
      .needs = ".vtu .msh .msh2 .mesh .node .ele .face .edge .xyz .csv .txt .pts .asc .dat .tsv" },
    { .commands = "view", .option = "--points",
      .excludes = "--inside --weights --threads --memory-limit --cut-through" },
    { .commands = "check", .option = "--retriangulate", .excludes = ".vtu .obj .csv .html" },
    { .commands = "convert", .option = "--tile", .needs = "*.pbwt" },
    { .commands = "convert", .option = "--weights", .needs = ".bin" },
    { .commands = "sample", .option = "--count", .excludes = "--radius" },
    { .commands = "sample", .option = "--uniform", .excludes = "--radius --fill --thin" },
    { .commands = "sample", .option = "--facet-normals", .needs = ".ply .obj .xyz .csv .txt .pts .asc .dat .tsv",
      .excludes = "--fill" },
    { .commands = "cells", .option = "--periodic", .needs = "--box" },
    { .commands = "cells", .option = "--box", .excludes = "--clip --lattice" },
    { .commands = "cells", .option = "--lattice", .excludes = "--clip --periodic" },
    { .commands = "cells", .option = "--gpu",
      .excludes = "--clip --lattice --merge .vtu .obj .svg .html .geojson" },
    { .commands = "plane", .option = "--coarsen", .needs = "--size" },
    { .commands = "plane", .option = "--gradation", .needs = REFINING },
    { .commands = "plane", .option = "--keep-boundary", .needs = REFINING },
    { .commands = "plane", .option = "--keep-segments", .needs = REFINING },
    { .commands = "plane", .option = "--steiner", .needs = REFINING },
    { .commands = "plane", .option = "--most", .needs = REFINING },
    { .commands = "plane", .option = "--rounds", .needs = "--smooth" },
    { .commands = "plane", .option = "--region-by", .needs = "*.geojson *.json" },
    { .commands = "improve", .option = "--only-smooth", .needs = "--smooth" },
    { .commands = "improve", .option = "--size", .excludes = "--error" },
    { .commands = "improve", .option = "--count", .needs = "--error" },
    { .commands = "solid", .option = "--wrap",
      .excludes = "--least-size --region-sizes --curvature --around --gradation --nested --sharp --close "
                  "--keep-faults --patches --split-patches --feature-angle --distance --rounds" },
    { .commands = "solid", .option = "--alpha", .needs = "--wrap" },
    { .commands = "solid", .option = "--offset", .needs = "--wrap" },
    { .commands = "solid", .option = "--cavities", .needs = "--wrap" },
    { .commands = "solid", .option = "--all-points", .needs = "--wrap" },
    { .commands = "solid", .option = "--fast", .needs = "--wrap" },
    { .commands = "tiles", .option = "--no-links", .excludes = "--no-mesh" },
};

/* The next word of a list with blanks between, of at most 15 letters; NULL at its end. */
static const char *next_word(const char **list, char word[16])
{
    const size_t length = *list == NULL ? 0 : strcspn(*list, " ");
    if (length == 0) {
        return NULL;
    }
    snprintf(word, 16, "%.*s", (int)length, *list);
    *list += length + ((*list)[length] == ' ');
    return word;
}

static int is_in(const char *list, const char *name)
{
    char word[16];
    while (next_word(&list, word) != NULL && strcmp(word, name) != 0) {
    }
    return strcmp(word, name) == 0;
}

/* Whether the job has what a word of a rule stands for. */
static int has(const job *j, const char *word)
{
    const size_t length = strlen(word), input = j->input != NULL ? strlen(j->input) : 0;
    const size_t end = input > 3 && strcmp(j->input + input - 3, ".gz") == 0 ? input - 3 : input;
    int i;
    if (word[0] == '*') {
        return end >= length && strncmp(j->input + end - (length - 1), word + 1, length - 1) == 0;
    }
    if (word[0] == '.') {
        for (i = 0; i < j->outputs && strcmp(ending_of(j, j->output[i]), word + 1) != 0; i++) {
        }
        return i < j->outputs;
    }
    return strcmp(word, "--generate") == 0 ? j->generate != NULL || j->input == NULL : is_given(j, word);
}

/* "--count 5", or "an input .bin" */
static const char *in_words(const job *j, const char *word, char text[100])
{
    const char *value = word[0] == '-' ? text_of(j, word) : NULL;
    snprintf(text, 100, "%s%.20s%s%.60s", word[0] == '*' ? "an input " : "", word + (word[0] == '*'),
             value != NULL ? " " : "", value != NULL ? value : "");
    return text;
}

static int applies(const job *j, const rule *r)
{
    const command *c = j->command;
    int g = 0;
    while (r->group != NULL && c->options[g] != NULL && c->options[g] != r->group) {
        g++;
    }
    return is_given(j, r->option) && (r->commands == NULL || is_in(r->commands, c->name))
        && (r->group == NULL || c->options[g] != NULL) && !(r->one_input && c->second != NULL);
}

static int check_rule(const job *j, const rule *r)
{
    const char *needs = r->needs, *excludes = r->excludes;
    char word[16], one[100], other[100], all[200] = "";
    int met = needs == NULL;
    while (!met && next_word(&needs, word) != NULL) {
        met = has(j, word);
        snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", *all == 0 ? "" : *needs == 0 ? " or " : ", ",
                 word + (word[0] == '*'));
    }
    if (!met) {
        return complain("%s: it needs %s%s", in_words(j, r->option, one),
                        r->needs[0] == '.' ? "an output " : r->needs[0] == '*' ? "an input " : "", all);
    }
    while (next_word(&excludes, word) != NULL) {
        if (has(j, word)) {
            return complain("%s and %s exclude each other", in_words(j, r->option, one), in_words(j, word, other));
        }
    }
    return 0;
}

/* What colours are named for must be there. */
static int check_colour(const job *j)
{
    const char *colour = text_of(j, "--colour");
    if (colour == NULL) {
        return 0;
    }
    if (strcmp(colour, "weight") == 0 && !is_given(j, "--weights")) {
        return complain("--colour weight: it needs --weights");
    }
    if (is_in("quality part thread round", colour) && is_given(j, "--points")) {
        return complain("--colour %s and --points exclude each other", colour);
    }
    if (is_in("thread round", colour) && is_in("live solid improve", j->command->name)) {
        return complain("--colour %s: pbw %s moves points, and keeps no record of that", colour, j->command->name);
    }
    return 0;
}

/* Names that tell their formats must not contradict --format. */
static int check_format(const job *j)
{
    const char *format = text_of(j, "--format");
    int i;
    for (i = 0; i < j->outputs && format != NULL; i++) {
        const char *ending = ending_of(j, j->output[i]);
        if (strcmp(ending, format + (*format == '.')) == 0) {
            return 0;
        }
    }
    return format == NULL ? 0 : complain("--format %s: it needs an output whose name tells no other format", format);
}

int check_effects(const job *j)
{
    size_t i;
    int status = check_colour(j);
    status = status != 0 ? status : check_format(j);
    for (i = 0; i < sizeof rules / sizeof *rules && status == 0; i++) {
        if (applies(j, rules + i)) {
            status = check_rule(j, rules + i);
        }
    }
    return status;
}
