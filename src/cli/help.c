/* Help texts, all printed from the tables. */
#include <string.h>

#include "cli/cli.h"
#include "mukca/effect.h"

enum { OPTION_COLUMN = 26 };

static void format_option(char *text, size_t size, const cli_option *option)
{
    char letter[8] = "";
    if (option->letter) snprintf(letter, sizeof letter, "-%c, ", option->letter);
    snprintf(text, size, "%s--%s%s%s", letter, option->name, option->argument ? " " : "",
             option->argument ? option->argument : "");
}

static void print_option(FILE *stream, const cli_option *option)
{
    char text[80];
    format_option(text, sizeof text, option);
    int column = fprintf(stream, "  %s", text);
    if (column + 2 > OPTION_COLUMN) {
        fputc('\n', stream);
        column = 0;
    }
    fprintf(stream, "%*s", OPTION_COLUMN - column, "");
    cli_print_words(stream, OPTION_COLUMN, OPTION_COLUMN, option->help, strlen(option->help));
    if (option->kind != CLI_CHOICE) return;
    fprintf(stream, "%*sone of:", OPTION_COLUMN, "");
    for (int i = 0; option->choices[i]; i++)
        fprintf(stream, "%s %s", i ? "," : "", option->choices[i]);
    fputc('\n', stream);
}

static void format_usage(char *text, size_t size, const cli_command *command)
{
    snprintf(text, size, "%s%s [options]%s%s", command->name,
             command->with & CLI_WITH_MODEL ? " --urdf FILE" : "", *command->synopsis ? " " : "",
             command->synopsis);
}

void cli_print_command_help(FILE *stream, const cli_command *command)
{
    const char *bold = cli_bold(stream), *plain = cli_plain(stream);
    fprintf(stream, "%smukca %s%s: ", bold, command->name, plain);
    cli_print_words(stream, 0, (int)strlen(command->name) + 8, command->summary,
                    strlen(command->summary));
    fputc('\n', stream);
    char usage[120];
    format_usage(usage, sizeof usage, command);
    fprintf(stream, "%sUsage:%s mukca %s\n\n", bold, plain, usage);
    cli_print_wrapped(stream, command->description);
    for (int common = 0; common < 2; common++) {
        bool any = false;
        for (const cli_option *o = NULL; (o = cli_next_option(command, o));) {
            if ((o->set != 0) != (common == 1)) continue;
            if (!any)
                fprintf(stream, "\n%s%s:%s\n", bold, common ? "Common options" : "Options", plain);
            any = true;
            print_option(stream, o);
        }
    }
    fprintf(stream, "\n%sExample:%s\n", bold, plain);
    cli_print_wrapped(stream, command->example);
}

/* `separator`: printed after each group. */
static void print_commands(FILE *stream, const char *separator)
{
    static const char *const title[] = {
#define GROUP_TITLE(name, title) title,
        CLI_GROUP_LIST(GROUP_TITLE)
#undef GROUP_TITLE
    };
    for (size_t g = 0; g < sizeof title / sizeof *title; g++) {
        bool any = false;
        for (const cli_command *const *c = cli_commands; *c; c++) {
            if ((size_t)(*c)->group != g) continue;
            if (!any) fprintf(stream, "%s%s%s\n", cli_bold(stream), title[g], cli_plain(stream));
            any = true;
            fprintf(stream, "  %-12s ", (*c)->name);
            cli_print_words(stream, 15, 15, (*c)->summary, strlen((*c)->summary));
        }
        if (any) fputs(separator, stream);
    }
}

void cli_print_overview(FILE *stream)
{
    fputs(
        "mukca calibrates robot arms and identifies the causes of the remaining error.\n\n"
        "Usage: mukca COMMAND [options] [arguments]\n\n",
        stream);
    print_commands(stream, "\n");
    fputs(
        "  mukca help COMMAND   options and an example\n"
        "  mukca help effects   the causes that a diagnosis can name\n"
        "  mukca help options   all options, as a table\n"
        "  mukca --version\n\n"
        "Files, columns and JSON keys: man mukca-formats.\n"
        "Exit codes: 0 done; 1 done, and the answer is a negative verdict; 2 bad usage;\n"
        "3 bad input; 4 transport or time-out; 5 not identifiable; 6 out of memory,\n"
        "or an output could not be written whole; 130 interrupted.\n",
        stream);
}

void cli_print_start(FILE *stream)
{
    fputs("mukca calibrates robot arms from joint angles with a ball in sockets, or poses.\n",
          stream);
    print_commands(stream, "");
    fputs("Start with `mukca help calibrate`; `mukca help` and `make demo` show more.\n", stream);
}

void cli_print_effects(FILE *stream)
{
    static const struct {
        int bit;
        const char *text;
    } needs[] = {{MUKCA_NEEDS_MASSES, "link masses"},
                 {MUKCA_NEEDS_ORDER, "samples in recording order"},
                 {MUKCA_NEEDS_PLACEMENTS, "two placements or more"},
                 {MUKCA_NEEDS_SOCKETS, "socket data"},
                 {MUKCA_NEEDS_COMMANDS, "commanded angles (--angles command)"}};
    cli_print_wrapped(stream,
                      "The effects that `mukca diagnose` can name and `mukca simulate --effect` "
                      "can make, with the unit of their coefficients:\n\n");
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        const mukca_effect_info *e = mukca_effect_table[kind];
        fprintf(stream, "%s%s%s (%s)\n    ", cli_bold(stream), e->name, cli_plain(stream), e->unit);
        cli_print_words(stream, 4, 4, e->sentence, strlen(e->sentence));
        bool any = false;
        for (size_t k = 0; k < sizeof needs / sizeof *needs; k++) {
            if (!(e->needs & needs[k].bit)) continue;
            fprintf(stream, "%s%s", any ? ", " : "    needs ", needs[k].text);
            any = true;
            /* a measured torque acts about the joint's own axis only */
            if (needs[k].bit == MUKCA_NEEDS_MASSES && e->site == MUKCA_SITE_ANGLE)
                fputs(" or measured efforts", stream);
        }
        if (any) fputc('\n', stream);
    }
}

void cli_print_options(FILE *stream)
{
    fputs("command\toption\tletter\targument\tvalues\n", stream);
    for (const cli_command *const *c = cli_commands; *c; c++)
        for (const cli_option *o = NULL; (o = cli_next_option(*c, o));) {
            const bool effect = o->argument && strncmp(o->argument, "EFFECT", 6) == 0;
            fprintf(stream, "%s\t--%s\t%.1s\t%s\t", (*c)->name, o->name,
                    o->letter ? &o->letter : "", o->argument ? o->argument : "");
            for (int kind = 0; effect && kind < MUKCA_EFFECT_COUNT; kind++)
                fprintf(stream, "%s%s", kind ? " " : "", mukca_effect_table[kind]->name);
            for (int i = 0; o->choices && o->choices[i]; i++)
                fprintf(stream, "%s%s", i ? " " : "", o->choices[i]);
            fputc('\n', stream);
        }
}
