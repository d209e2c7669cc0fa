/* The list of commands, in the order of the help: a new command adds one row here. */
#include <string.h>

#include "cli/cli.h"

#define CLI_COMMAND_LIST(X) \
    X(capture)              \
    X(serve)                \
    X(send)                 \
    X(simulate)             \
    X(plan)                 \
    X(calibrate)            \
    X(recalibrate)          \
    X(evaluate)             \
    X(diagnose)             \
    X(report)               \
    X(compensate)           \
    X(export)               \
    X(fk)

#define DECLARE_COMMAND(name) extern const cli_command cli_command_##name;
CLI_COMMAND_LIST(DECLARE_COMMAND)
#undef DECLARE_COMMAND

const cli_command *const cli_commands[] = {
#define COMMAND_ADDRESS(name) &cli_command_##name,
    CLI_COMMAND_LIST(COMMAND_ADDRESS)
#undef COMMAND_ADDRESS
        NULL};

const cli_command *cli_find_command(const char *name)
{
    for (const cli_command *const *c = cli_commands; *c; c++)
        if (strcmp((*c)->name, name) == 0) return *c;
    return NULL;
}
