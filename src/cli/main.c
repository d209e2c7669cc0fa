/* main(): find the command, parse its options, run it, report its error. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "base/suggest.h"
#include "base/utf8.h"
#include "cli/cli.h"
#include "mukca/version.h"

static mukca_status unknown_command(const char *name)
{
    static const char *const others[] = {"help", "--version", "--help"};
    char text[MUKCA_SUGGEST_TEXT];
    const char *meant = NULL, *what = name[0] == '-' ? "option" : "command";
    int best = 99;
    for (const cli_command *const *c = cli_commands; *c; c++)
        if (mukca_suggest_better(&best, name, (*c)->name)) meant = (*c)->name;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (mukca_suggest_better(&best, name, others[i])) meant = others[i];
    if (strcmp(name, "-V") == 0 || strcmp(name, "version") == 0) meant = "--version";
    if (strncmp(name, "effect", 6) == 0) meant = "help effects";
    fprintf(stderr, "mukca: unknown %s '%s'; %s\n", what, name,
            mukca_suggest_text(text, meant, "`mukca help` lists them"));
    return MUKCA_USAGE;
}

static mukca_status help(const char *topic)
{
    const cli_command *command = topic ? cli_find_command(topic) : NULL;
    if (!topic || strcmp(topic, "help") == 0)
        cli_print_overview(stdout);
    else if (strcmp(topic, "effects") == 0)
        cli_print_effects(stdout);
    else if (strcmp(topic, "options") == 0)
        cli_print_options(stdout);
    else if (command)
        cli_print_command_help(stdout, command);
    else
        return unknown_command(topic);
    return MUKCA_OK;
}

static mukca_status run_command(const cli_command *command, int argc, char **argv)
{
    cli_call call = {.command = command, .argc = argc, .argv = argv};
    call.started = cli_elapsed(&call); /* reads the clock: started is 0 */
    bool wants_help;
    mukca_status status = cli_parse(&call, &wants_help, argc, argv);
    if (status == MUKCA_OK && wants_help)
        cli_print_command_help(stdout, command);
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
        cli_print_start(stderr);
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

/* Fix the threshold for mmap.  Zeroed pages from the kernel cost nothing until used, but glibc
 * raises the threshold, and clears recycled memory, once a large block was freed. */
static void keep_large_blocks_apart(void)
{
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 128 * 1024); /* glibc's initial value */
#endif
}

int main(int argc, char **argv)
{
    keep_large_blocks_apart();
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
