/* The list of commands, in the order of the help (a new command adds one row here), and their run.
 */
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
    X(motion)               \
    X(fleet)                \
    X(report)               \
    X(compare)              \
    X(compensate)           \
    X(align)                \
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

static mukca_status run_steps(cli_call *call)
{
    const cli_command *c = call->command;
    const cli_common *given = call->common;
    const bool table = c->table && (given->output || !given->json), json = c->json && given->json;
    MUKCA_TRY(c->check ? c->check(call) : MUKCA_OK);
    MUKCA_TRY(cli_read(call, c->reads));
    MUKCA_TRY(c->run ? c->run(call) : MUKCA_OK);
    MUKCA_TRY(table ? cli_write_table(call, c->table) : MUKCA_OK);
    MUKCA_TRY(json ? cli_write_json(call, c->json(call)) : MUKCA_OK);
    return c->print ? c->print(call) : MUKCA_OK;
}

mukca_status cli_run(cli_call *call)
{
    MUKCA_TRY(cli_check_outputs(call));
    call->session = MUKCA_TAKE(&call->pool, cli_session, 1);
    call->work = mukca_pool_take(&call->pool, 1, call->command->work_size);
    if (call->pool.failed) return cli_fail(call, MUKCA_MEMORY, "out of memory");
    const mukca_status status = run_steps(call);
    if (call->command->release) call->command->release(call->work);
    mukca_dataset_free(&call->session->data);
    mukca_dataset_free(&call->session->test);
    return status;
}
