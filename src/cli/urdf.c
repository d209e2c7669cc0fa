/* mukca urdf: a URDF from a Denavit-Hartenberg table. */
#include <string.h>

#include "base/file.h"
#include "base/utf8.h"
#include "cli/cli.h"
#include "io/output.h"
#include "io/urdf.h"

typedef struct {
    cli_common common;
    const char *dh;
    int convention; /* -1: not given */
} urdf_options;

static const cli_option options[] = {
    CLI_OPTION(urdf_options, dh, "dh", CLI_INPUT, "FILE",
               "the table: joint, a, alpha, d, theta, one row per joint"),
    CLI_CHOICE_OPTION(urdf_options, convention, "convention", "NAME", mukca_dh_convention_name,
                      "what the rows mean (default: as the table says, else standard)"),
    CLI_UNITS_OPTION, CLI_OUTPUT_OPTION("where to write it (default: standard output)"),
    CLI_LAST_OPTIONS};

static const urdf_options defaults = {.convention = -1};

/* Set the robot's name from the file name, without folder and ending. */
static void name_robot(mukca_chain *chain, const char *path)
{
    const char *file = mukca_file_name(path);
    snprintf(chain->robot, sizeof chain->robot, "%.*s", (int)mukca_utf8_fit(file, 40), file);
    char *dot = strchr(chain->robot, '.');
    if (dot && dot > chain->robot) *dot = '\0';
    if (!chain->robot[0] || strcmp(path, "-") == 0)
        snprintf(chain->robot, sizeof chain->robot, "arm");
}

static mukca_status load(cli_call *call, mukca_chain *chain)
{
    const urdf_options *o = call->options;
    mukca_dh dh;
    bool stated = false;
    mukca_rows_format format;
    mukca_status status = cli_read_format(call, &format);
    if (status == MUKCA_OK) status = mukca_dh_read(&dh, &stated, o->dh, &format, &call->error);
    if (status != MUKCA_OK) return status;
    if (stated && o->convention >= 0 && o->convention != (int)dh.convention)
        return mukca_fail(&call->error, MUKCA_USAGE, "%s declares a %s table; omit --convention",
                          mukca_file_shown(o->dh), mukca_dh_convention_name[dh.convention]);
    if (o->convention >= 0) dh.convention = (mukca_dh_convention)o->convention;
    if (!stated && o->convention < 0)
        cli_note(call,
                 "the table is taken for a standard one; --convention modified reads it otherwise");
    mukca_dh_to_chain(chain, &dh);
    name_robot(chain, o->dh);
    return MUKCA_OK;
}

static mukca_status run(cli_call *call)
{
    const urdf_options *o = call->options;
    mukca_chain *chain = &call->session->model.chain;
    mukca_output output = {0};
    if (!o->dh)
        return mukca_fail(&call->error, MUKCA_USAGE, "--dh FILE is needed: the table to convert");
    mukca_status status = load(call, chain);
    if (status == MUKCA_OK) status = cli_output_open(call, &output);
    if (status == MUKCA_OK) mukca_urdf_write(output.stream, chain);
    return mukca_output_finish(&output, status, &call->error);
}

const cli_command cli_command_urdf = {
    .name = "urdf",
    .group = CLI_MEASURE,
    .summary = "a URDF from a Denavit-Hartenberg table",
    .synopsis = "",
    .description =
        "Writes the URDF of an arm of which only a Denavit-Hartenberg table is known. The table "
        "(TSV or CSV) has the columns joint, a, alpha, d and theta, in m and rad or --units, and "
        "may have "
        "type (revolute, continuous, prismatic, fixed; default: revolute), lower and upper. Joints "
        "without limits turn without end. Row by row, the pose of the tip is the product of\n"
        "  standard  Rz(theta + q) Tz(d) Tx(a) Rx(alpha)\n"
        "  modified  Rx(alpha) Tx(a) Rz(theta + q) Tz(d)\n\n"
        "A fixed row before the first joint places the base, one behind the last joint the tool. "
        "mukca export -f dh and -f mdh write such tables; this command reads them back.",
    .example =
        "mukca export --urdf data/demo/arm.urdf -f dh -o build/demo/arm.dh\n"
        "mukca urdf --dh build/demo/arm.dh",
    .options = options,
    .options_size = sizeof(urdf_options),
    .defaults = &defaults,
    .run = run,
};
