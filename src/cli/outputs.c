/* Outputs of commands: checks before long work, opening, files written by several commands. */
#include <fnmatch.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "cli/cli.h"

/* The path that was given for an option, CLI_INPUT or CLI_OUTPUT; NULL: none. */
static const char *path_of(const cli_call *call, const cli_option *option)
{
    return *(const char **)cli_option_member(call, option);
}

/* Is `path` the input or, if the input is a placement's folder, one of the files read in it? */
static bool is_input(const char *path, const char *input)
{
    char file[1300];
    if (!input || access(input, F_OK) != 0) return false;
    const char *name = mukca_file_name(path);
    if (fnmatch("hole_*.csv", name, 0) != 0) return mukca_output_same(path, input);
    snprintf(file, sizeof file, "%.1000s/%.255s", input, name);
    return mukca_output_same(path, input) || mukca_output_same(path, file);
}

/* Is `path` the file that the shell opened as standard input? */
static bool is_standard_input(const char *path)
{
    struct stat named, input;
    return stat(path, &named) == 0 && fstat(STDIN_FILENO, &input) == 0 && S_ISREG(input.st_mode) &&
           named.st_dev == input.st_dev && named.st_ino == input.st_ino;
}

static bool is_among(const char *path, const cli_list *inputs)
{
    for (int i = 0; i < inputs->n; i++)
        if (is_input(path, inputs->items[i])) return true;
    return false;
}

static mukca_status check_output(cli_call *call, const cli_option *output)
{
    if (output->kind != CLI_OUTPUT || !path_of(call, output)) return MUKCA_OK;
    const char *path = path_of(call, output);
    bool same = is_among(path, &call->arguments) || is_standard_input(path);
    bool before = true;
    for (const cli_option *o = NULL; (o = cli_next_option(call->command, o));) {
        before &= o != output;
        if (o->kind == CLI_INPUT) same |= is_input(path, path_of(call, o));
        if (o->kind == CLI_REST) same |= is_among(path, cli_option_member(call, o));
        if (o->kind == CLI_OUTPUT && before && mukca_output_same(path, path_of(call, o)))
            return cli_fail(call, MUKCA_USAGE, "--%s and --%s cannot both go to %s", o->name,
                            output->name, path);
    }
    if (same)
        return cli_fail(call, MUKCA_USAGE,
                        "%.120s is an input of this command; refusing to overwrite it", path);
    return call->command->grows ? MUKCA_OK
                                : mukca_output_check(path, call->common->force, &call->error);
}

mukca_status cli_check_outputs(cli_call *call)
{
    for (const cli_option *o = NULL; (o = cli_next_option(call->command, o));)
        MUKCA_TRY(check_output(call, o));
    return MUKCA_OK;
}

void cli_print_verdict(const cli_call *call, FILE *stream)
{
    const mukca_acceptance *a = &call->session->model.offsets.acceptance;
    if (a->given && !a->accepted)
        fprintf(stream, "# the offsets table was not accepted: %s\n", a->reason);
}

mukca_status cli_write(cli_call *call, const char *path, cli_writer *write)
{
    mukca_output output;
    if (!path) return MUKCA_OK;
    mukca_status status = mukca_output_open(&output, path, call->common->force, &call->error);
    if (status == MUKCA_OK) status = write(call, output.stream);
    return mukca_output_finish(&output, status, &call->error);
}

mukca_status cli_write_table(cli_call *call, cli_writer *write)
{
    const char *path = call->common->output;
    call->printed = !path;
    return cli_write(call, path ? path : "-", write);
}

mukca_status cli_write_page(cli_call *call, FILE *stream, mukca_page page)
{
    char *command, when[32];
    size_t size;
    FILE *line = open_memstream(&command, &size);
    if (!line) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    fprintf(line, "mukca %s", call->command->name);
    for (int i = 0; i < call->argc; i++) fprintf(line, " %s", call->argv[i]);
    const bool whole = mukca_file_close(line, &command);
    mukca_offsets_time(when);
    page.command = command;
    page.when = when;
    if (whole) mukca_page_write(stream, &page);
    free(command);
    return whole ? MUKCA_OK : cli_fail(call, MUKCA_MEMORY, "out of memory");
}
