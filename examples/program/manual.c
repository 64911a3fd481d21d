/* manual.c: the manual page and the completions for shells.
   In: the tables of commands and options.  Out: text, which `make install` installs. */
#include "program.h"

/* The command lines that end the help of each command; tests/program.sh runs them. */
static const struct { const char *command, *line[EXAMPLES]; } examples[] = {
    { "mesh", { "pbw points.csv -o mesh.vtu", "pbw mesh model.obj --inside -o mesh.msh -o picture.svg" } },
    { "sample", { "pbw sample model.obj --count 3000 -o points.ply",
                  "pbw sample model.obj --fill lattice -o points.csv" } },
    { "check", { "pbw check model.obj", "pbw check mesh.msh" } },
    { "convert", { "pbw convert model.obj model.stl", "pbw convert mesh.msh -o mesh.vtu" } },
    { "bench", { "pbw bench --generate sphere 10K", "pbw bench points.csv --threads 2" } },
    { "view", { "pbw view model.obj", "pbw view mesh.msh -o mesh.html --cut 1,0,0,0" } },
    { "locate", { "pbw locate points.csv queries.csv", "pbw locate points.csv queries.csv -o found.csv" } },
    { "nearest", { "pbw nearest points.csv queries.csv -k 8 -o near.csv",
                   "pbw nearest points.csv queries.csv -o -" } },
    { "cells", { "pbw cells points.csv --box 0,0,0,1,1,1 -o cells.vtu",
                 "pbw cells points.csv --box 0,0,0,1,1,1 --periodic xyz -o cells.csv" } },
    { "plane", { "pbw plane domain.poly --angle 30 -o mesh.svg", "pbw plane domain.poly --size 0.2 -o mesh.vtu" } },
    { "improve", { "pbw improve mesh.msh -o better.msh", "pbw improve mesh.msh --smooth odt -o better.vtu" } },
    { "fill", { "pbw fill model.obj -o filled.vtu", "pbw fill model.obj --conforming -o filled.msh" } },
    { "solid", { "pbw solid model.obj -o solid.vtu", "pbw solid model.obj --size 0.2 --patches -o solid.msh" } },
    { "wrap", { "pbw wrap model.obj -o wrapped.stl",
                "pbw wrap model.obj --alpha 0.3 --offset 0.02 -o wrapped.vtu" } },
    { "tiles", { "pbw tiles points.csv -o mesh.pbwt", "pbw tiles points.csv --memory-limit 1G --no-mesh" } },
    { "hash", { "pbw hash points.csv", "pbw hash mesh.pbwt" } },
    { "live", { "pbw live points.csv --script changes.csv",
                "pbw live points.csv --script changes.csv -o after.vtu" } },
};

const char *example_of(const command *c, int i)
{
    size_t k;
    for (k = 0; k + 1 < sizeof examples / sizeof *examples && strcmp(examples[k].command, c->name) != 0; k++) {
    }
    return examples[k].line[i];
}

/* Prints text for troff: a dot or a quote at the start of a line, and each backslash, need an escape. */
static void put_troff(const char *text)
{
    int first = 1;
    for (; *text != 0; text++) {
        if (first && (*text == '.' || *text == '\'')) {
            fputs("\\&", stdout);
        }
        if (*text == '\\' || *text == '-') {
            putchar('\\');
        }
        putchar(*text);
        first = *text == '\n';
    }
}

static void print_page(const command *const *commands)
{
    const option *o;
    int i, k;
    printf(".TH PBW 1 \"\" \"pbw %d.%d.%d\" \"User Commands\"\n.SH NAME\n"
           "pbw \\- exact triangulations of points, meshes of plane domains and solids, cells\n.SH COMMANDS\n",
           PBW_VERSION_MAJOR, PBW_VERSION_MINOR, PBW_VERSION_PATCH);
    for (i = 0; commands[i] != NULL; i++) {
        printf(".TP\n.B pbw %s\n%s\n", commands[i]->name, commands[i]->summary);
    }
    for (i = 0; commands[i] != NULL; i++) {
        printf(".SH PBW %s\n.nf\n", commands[i]->name);
        put_troff(commands[i]->usage);
        puts(".fi");
        for (k = 0; commands[i]->options[k] != NULL; k++) {
            for (o = commands[i]->options[k]; o->name != NULL; o++) {
                fputs(".TP\n.B ", stdout);
                put_troff(o->name);
                if (o->value != NULL) {
                    fputs(" \\fI", stdout);
                    put_troff(o->value);
                    fputs("\\fR", stdout);
                }
                putchar('\n');
                put_troff(o->help);
                putchar('\n');
            }
        }
        puts(".PP\nExamples:\n.nf");
        for (k = 0; k < EXAMPLES; k++) {
            fputs("  ", stdout);
            put_troff(example_of(commands[i], k));
            putchar('\n');
        }
        puts(".fi");
    }
    puts(".SH EXIT STATUS\n0 done, 1 failure, 2 wrong usage");
}

static void list_options(const command *c)
{
    const option *o;
    int k;
    for (k = 0; c->options[k] != NULL; k++) {
        for (o = c->options[k]; o->name != NULL; o++) {
            printf(" %s", o->name);
        }
    }
    fputs(" --help", stdout);
}

/* The choices of options that have some: the command, the option, and the words, between these texts. */
static void list_choices(const command *const *commands, const char *before, const char *between, const char *after)
{
    const option *o;
    int i, k, n;
    for (i = 0; commands[i] != NULL; i++) {
        for (k = 0; commands[i]->options[k] != NULL; k++) {
            for (o = commands[i]->options[k]; o->name != NULL; o++) {
                char words[512] = "";
                for (n = 0; o->choices != NULL && o->choices[n] != NULL; n++) {
                    snprintf(words + strlen(words), sizeof words - strlen(words), "%s%s", n > 0 ? " " : "",
                             o->choices[n]);
                }
                if (n > 0) {
                    printf("%s%s:%s%s%s%s", before, commands[i]->name, o->name, between, words, after);
                }
            }
        }
    }
}

/* Both completions: the command, then its options, the choices of an option, or files. */
static void print_bash(const command *const *commands)
{
    int i;
    puts("# Completion of pbw for bash.\n_pbw() {\n"
         "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} options= choices=");
    fputs("    local commands=\"help", stdout);
    for (i = 0; commands[i] != NULL; i++) {
        printf(" %s", commands[i]->name);
    }
    puts("\"\n    case ${COMP_WORDS[1]} in");
    for (i = 0; commands[i] != NULL; i++) {
        printf("    %s) options=\"", commands[i]->name);
        list_options(commands[i]);
        puts("\" ;;");
    }
    fputs("    *) options=\"", stdout);
    list_options(commands[0]);
    puts("\" ;;\n    esac\n    case ${COMP_WORDS[1]}:$before in");
    list_choices(commands, "    ", ") choices=\"", "\" ;;\n");
    puts("    esac\n"
         "    if [ -n \"$choices\" ]; then\n"
         "        COMPREPLY=($(compgen -W \"$choices\" -- \"$word\"))\n"
         "    elif [ \"${word#-}\" != \"$word\" ]; then\n"
         "        COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
         "    elif [ \"$COMP_CWORD\" = 1 ]; then\n"
         "        COMPREPLY=($(compgen -W \"$commands\" -- \"$word\") $(compgen -f -- \"$word\"))\n"
         "    else\n"
         "        COMPREPLY=($(compgen -f -- \"$word\"))\n"
         "    fi\n"
         "}\n"
         "complete -o filenames -F _pbw pbw");
}

static void print_zsh(const command *const *commands)
{
    int i;
    puts("#compdef pbw\n# Completion of pbw for zsh.\nlocal -a commands options\ncommands=(");
    for (i = 0; commands[i] != NULL; i++) {
        printf("    '%s:%s'\n", commands[i]->name, commands[i]->summary);
    }
    puts(")\ncase $words[2] in");
    for (i = 0; commands[i] != NULL; i++) {
        printf("%s) options=(", commands[i]->name);
        list_options(commands[i]);
        puts(") ;;");
    }
    fputs("*) options=(", stdout);
    list_options(commands[0]);
    puts(") ;;\nesac\ncase $words[2]:$words[CURRENT-1] in");
    list_choices(commands, "", ") compadd -- ", "; return ;;\n");
    puts("esac\n"
         "if [[ $PREFIX == -* ]]; then\n"
         "    compadd -- $options\n"
         "else\n"
         "    (( CURRENT == 2 )) && _describe command commands\n"
         "    _files\n"
         "fi");
}

int print_manual(const char *kind, const command *const *commands)
{
    if (strcmp(kind, "--man") == 0) {
        print_page(commands);
    } else if (strcmp(kind, "--bash") == 0) {
        print_bash(commands);
    } else if (strcmp(kind, "--zsh") == 0) {
        print_zsh(commands);
    } else {
        return 0;
    }
    return 1;
}
