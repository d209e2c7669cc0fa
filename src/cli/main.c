/* main(): find the command, parse its options, run it, report its error; help texts. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/suggest.h"
#include "base/text.h"
#include "cli/cli.h"
#include "mukca/effect.h"
#include "mukca/version.h"

/* ---- help texts, all printed from the tables ---- */

enum { OPTION_COLUMN = 26 };

static void print_option(FILE *stream, const cli_option *option)
{
    int column = fprintf(stream, "  ");
    if (option->letter) column += fprintf(stream, "-%c, ", option->letter);
    column += fprintf(stream, "--%s", option->name);
    if (option->argument) column += fprintf(stream, " %s", option->argument);
    if (column + 2 > OPTION_COLUMN) {
        fputc('\n', stream);
        column = 0;
    }
    fprintf(stream, "%*s", OPTION_COLUMN - column, "");
    cli_print_words(stream, OPTION_COLUMN, OPTION_COLUMN, option->help, strlen(option->help));
    if (option->kind != CLI_CHOICE) return;
    char list[400] = "";
    mukca_text names = MUKCA_TEXT(list);
    mukca_text_put(&names, "one of:");
    for (int i = 0; option->choices[i]; i++)
        mukca_text_put(&names, "%s %s", i ? "," : "", option->choices[i]);
    fprintf(stream, "%*s", OPTION_COLUMN, "");
    cli_print_words(stream, OPTION_COLUMN, OPTION_COLUMN, list, names.used);
}

static void print_command_help(FILE *stream, const cli_command *command)
{
    const char *bold = cli_bold(stream), *plain = cli_plain(stream);
    fprintf(stream, "%smukca %s%s: ", bold, command->name, plain);
    cli_print_words(stream, 0, (int)strlen(command->name) + 8, command->summary,
                    strlen(command->summary));
    fputc('\n', stream);
    fprintf(stream, "%sUsage:%s mukca %s%s [options]%s%s\n\n", bold, plain, command->name,
            command->with & CLI_WITH_MODEL ? " --urdf FILE" : "", *command->synopsis ? " " : "",
            command->synopsis);
    cli_print_wrapped(stream, command->description);
    int titled = -1; /* 1: the common options, which come last */
    for (const cli_option *o = NULL; (o = cli_next_option(command, o));) {
        const int common = o->set != 0;
        if (common != titled)
            fprintf(stream, "\n%s%s:%s\n", bold, common ? "Common options" : "Options", plain);
        titled = common;
        print_option(stream, o);
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
        fprintf(stream, "%s%s%s\n", cli_bold(stream), title[g], cli_plain(stream));
        for (const cli_command *const *c = cli_commands; *c; c++) {
            if ((size_t)(*c)->group != g) continue;
            fprintf(stream, "  %-12s ", (*c)->name);
            cli_print_words(stream, 15, 15, (*c)->summary, strlen((*c)->summary));
        }
        fputs(separator, stream);
    }
}

static void print_overview(FILE *stream)
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

static void print_start(FILE *stream)
{
    fputs("mukca calibrates robot arms from joint angles with a ball in sockets, or poses.\n",
          stream);
    print_commands(stream, "");
    fputs("Start with `mukca help calibrate`; `mukca help` and `make demo` show more.\n", stream);
}

static void print_effects(FILE *stream)
{
    cli_print_wrapped(stream,
                      "The effects that `mukca diagnose` can name and `mukca simulate --effect` "
                      "can make, with the unit of their coefficients:\n\n");
    for (int kind = 0; kind < MUKCA_EFFECT_COUNT; kind++) {
        const mukca_effect_info *e = mukca_effect_table[kind];
        fprintf(stream, "%s%s%s (%s)\n    ", cli_bold(stream), e->name, cli_plain(stream), e->unit);
        cli_print_words(stream, 4, 4, e->sentence, strlen(e->sentence));
    }
}

static void print_options(FILE *stream)
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

/* ---- */

static mukca_status unknown_command(const char *name)
{
    static const char *const others[] = {"help", "--version", "--help"};
    char text[MUKCA_SUGGEST_TEXT], shown[100];
    const char *meant = NULL, *what = name[0] == '-' ? "option" : "command";
    int best = 99;
    for (const cli_command *const *c = cli_commands; *c; c++)
        if (mukca_suggest_better(&best, name, (*c)->name)) meant = (*c)->name;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (mukca_suggest_better(&best, name, others[i])) meant = others[i];
    if (strcmp(name, "-V") == 0 || strcmp(name, "version") == 0) meant = "--version";
    if (strncmp(name, "effect", 6) == 0) meant = "help effects";
    snprintf(shown, sizeof shown, "%s", name);
    mukca_utf8_mend(shown);
    fprintf(stderr, "mukca: unknown %s '%s'; %s\n", what, shown,
            mukca_suggest_text(text, meant, "`mukca help` lists them"));
    return MUKCA_USAGE;
}

static mukca_status help(const char *topic)
{
    const cli_command *command = topic ? cli_find_command(topic) : NULL;
    if (!topic || strcmp(topic, "help") == 0)
        print_overview(stdout);
    else if (strcmp(topic, "effects") == 0)
        print_effects(stdout);
    else if (strcmp(topic, "options") == 0)
        print_options(stdout);
    else if (command)
        print_command_help(stdout, command);
    else
        return unknown_command(topic);
    return MUKCA_OK;
}

static mukca_status run_command(const cli_command *command, int argc, char **argv)
{
    cli_call call = {.command = command};
    call.started = cli_elapsed(&call); /* reads the clock: started is 0 */
    bool wants_help;
    mukca_status status = cli_parse(&call, &wants_help, argc, argv);
    if (status == MUKCA_OK && wants_help)
        print_command_help(stdout, command);
    else if (status == MUKCA_OK)
        status = cli_run(&call);
    if (call.common && call.common->verbose)
        cli_log(&call, "%s took %.3g s\n", command->name, cli_elapsed(&call));
    if (status != MUKCA_OK && status != MUKCA_MEMORY && cli_interrupted()) {
        if (status != MUKCA_INTERRUPTED || !call.error.text[0])
            snprintf(call.error.text, sizeof call.error.text, "interrupted; nothing was written");
        status = MUKCA_INTERRUPTED;
    }
    mukca_utf8_mend(call.error.text); /* foreign texts, a character cut by truncation */
    if (status != MUKCA_OK && call.error.text[0])
        fprintf(stderr, "mukca %s: %s\n", command->name, call.error.text);
    cli_call_free(&call);
    return status;
}

static mukca_status dispatch(int argc, char **argv)
{
    if (argc < 2) {
        print_start(stderr);
        return MUKCA_USAGE;
    }
    const char *word = argv[1];
    const char *second = argc > 2 ? argv[2] : NULL;
    if (strcmp(word, "--version") == 0) {
        puts("mukca " MUKCA_VERSION);
        return MUKCA_OK;
    }
    if (strcmp(word, "help") == 0 || strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0)
        return help(second);
    const cli_command *command = cli_find_command(word);
    return command ? run_command(command, argc - 2, argv + 2) : unknown_command(word);
}

/* A file opened while a standard stream is closed would get its descriptor and its output.  The
 * stand-in is read-only: output that would be lost is a write error. */
static void occupy_standard_streams(void)
{
    int file;
    do file = open("/dev/null", O_RDONLY);
    while (file >= 0 && file <= STDERR_FILENO);
    if (file >= 0) close(file);
}

int main(int argc, char **argv)
{
    occupy_standard_streams();
    cli_catch_interrupts();
    cli_json_watch();
    mukca_status status = dispatch(argc, argv);
    if (!mukca_output_flush(stdout) && (status == MUKCA_OK || status == MUKCA_NEGATIVE)) {
        fprintf(stderr, "mukca: standard output: cannot write: %s\n", strerror(errno));
        status = MUKCA_MEMORY;
    }
    return (int)status;
}
