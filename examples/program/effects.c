/* effects.c: refuses options that would have no effect, or exclude each other, before the work. */
#include "program.h"

/* What `needs` and `excludes` hold, with blanks between: --name: that option; .ending: an output of that format;
   *.ending: an input of such a name. */
typedef struct rule {
    const char *commands;                            /* with blanks between; NULL: all that have the option */
    const char *option;
    const char *needs;                               /* one of these; NULL: nothing */
    const char *excludes;                            /* none of these; NULL: anything may be there */
} rule;

#define REFINING "--angle --area --size --conforming"

static const rule rules[] = {
    { "mesh check convert bench view locate nearest cells plane tiles hash live", "--seed", "--generate", NULL },
    { "mesh check convert bench view cells plane tiles hash live", "--columns", NULL, "--generate *.pbwt *.bin" },
    { "mesh check convert bench view cells plane tiles hash live", "--decimal-comma", NULL,
      "--generate *.pbwt *.bin" },
    { NULL, "--keep", NULL, "--generate *.pbwt *.bin" },
    { NULL, "--weights", NULL, "--generate *.pbwt" },
    { "check convert hash", "--dim", NULL, "*.pbwt" },
    { NULL, "--surface", "--inside", NULL },
    { NULL, "--title", ".html", NULL },
    { NULL, "--colour", ".html", NULL },
    { NULL, "--cut-through", ".html", NULL },
    { NULL, "--colour-outside", ".html", NULL },
    { NULL, "--eye", ".html .svg", NULL },
    { NULL, "--up", ".html .svg", NULL },
    { NULL, "--cut", ".html .svg", NULL },
    { NULL, "--text", ".vtu .msh .ply .stl", NULL },
    { NULL, "--no-orphans", ".vtu .msh .msh2 .mesh .node .ele .face .edge .xyz .csv .txt .pts .asc .dat .tsv", NULL },
    { "view", "--points", NULL, "--inside --weights --threads --memory-limit --cut-through" },
    { "convert", "--tile", "*.pbwt", NULL },
    { "convert", "--weights", ".bin", NULL },
    { "sample", "--count", NULL, "--radius" },
    { "sample", "--uniform", NULL, "--radius --fill --thin" },
    { "sample", "--facet-normals", ".ply .obj .xyz .csv .txt .pts .asc .dat .tsv", "--fill" },
    { "cells", "--periodic", "--box", NULL },
    { "cells", "--box", NULL, "--clip --lattice" },
    { "cells", "--lattice", NULL, "--clip --periodic" },
    { "plane", "--coarsen", "--size", NULL },
    { "plane", "--gradation", REFINING, NULL },
    { "plane", "--keep-boundary", REFINING, NULL },
    { "plane", "--keep-segments", REFINING, NULL },
    { "plane", "--steiner", REFINING, NULL },
    { "plane", "--most", REFINING, NULL },
    { "plane", "--rounds", "--smooth", NULL },
    { "plane", "--region-by", "*.geojson *.json", NULL },
    { "improve", "--only-smooth", "--smooth", NULL },
    { "improve", "--size", NULL, "--error" },
    { "improve", "--count", "--error", NULL },
    { "tiles", "--no-links", NULL, "--no-mesh" },
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
        if (is_given(j, rules[i].option)
            && (rules[i].commands == NULL || is_in(rules[i].commands, j->command->name))) {
            status = check_rule(j, rules + i);
        }
    }
    return status;
}
