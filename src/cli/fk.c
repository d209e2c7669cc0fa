/* mukca fk: forward kinematics of rows of joint angles. */
#include <string.h>

#include "cli/cli.h"

typedef struct {
    cli_common common;
    bool pose;
} fk_options;

static const cli_option options[] = {
    CLI_OPTION(fk_options, pose, "pose", CLI_FLAG, NULL,
               "print orientations too, as quaternions qw qx qy qz"),
    CLI_OUTPUT_OPTION("write the table there (default: standard output)"),
    {.name = NULL}};

/* Displacement by the effects of --offsets in one row. */
static void displace(mukca_displacement *displacement, mukca_row_state *states,
                     const cli_model *model, const mukca_rows *rows, const mukca_row *row)
{
    const mukca_offsets *offsets = &model->offsets;
    mukca_row_reading reading = mukca_row_read(row, rows);
    for (int p = 0; row->placement && p < offsets->n_placements; p++)
        if (strcmp(offsets->placements[p], row->placement) == 0) reading.placement = p;
    mukca_effects_displacement(displacement, offsets->effects, offsets->n_effects, &model->chain,
                               &model->geometry, mukca_row_state_next(states, &reading));
}

static void print_row(FILE *stream, bool pose, const mukca_frame *T)
{
    fprintf(stream, "%.17g\t%.17g\t%.17g", T->p[0], T->p[1], T->p[2]);
    if (pose) {
        double q[4];
        mukca_rotation_to_quaternion(q, T->R);
        fprintf(stream, "\t%.17g\t%.17g\t%.17g\t%.17g", q[0], q[1], q[2], q[3]);
    }
    fputc('\n', stream);
}

static mukca_status convert(cli_call *call, FILE *stream, const char *path, bool first)
{
    const fk_options *o = call->options;
    const cli_model *model = &call->session->model;
    mukca_rows *rows = call->work;
    mukca_row row;
    mukca_row_state states;
    mukca_rows_options header = {.kind = MUKCA_EITHER, .unchecked = true};
    MUKCA_TRY(cli_read_format(call, &header.format));
    MUKCA_TRY(mukca_rows_open(rows, path, &model->chain, &header, &call->error));
    mukca_row_state_start(&states, model->chain.n_joints);
    if (first) cli_print_verdict(call, stream);
    if (first) fputs(o->pose ? "x_m\ty_m\tz_m\tqw\tqx\tqy\tqz\n" : "x_m\ty_m\tz_m\n", stream);
    while (!ferror(stream) && !cli_interrupted() && mukca_rows_next(rows, &row)) {
        mukca_displacement displacement;
        mukca_frame T;
        if (model->offsets.n_effects) displace(&displacement, &states, model, rows, &row);
        mukca_fk_pose(&T, &model->geometry, row.q, model->offsets.n_effects ? &displacement : NULL);
        print_row(stream, o->pose, &T);
    }
    const mukca_status status = mukca_rows_close(rows);
    return status == MUKCA_OK && cli_interrupted() ? MUKCA_INTERRUPTED : status;
}

static mukca_status write_tips(cli_call *call, FILE *stream)
{
    const cli_list input = cli_inputs(call);
    for (int i = 0; i < input.n; i++) MUKCA_TRY(convert(call, stream, input.items[i], i == 0));
    return MUKCA_OK;
}

const cli_command cli_command_fk = {
    .name = "fk",
    .group = CLI_USE,
    .summary = "position or pose of the tip for rows of joint angles",
    .synopsis = "[FILE...]",
    .description =
        "Reads tables with one column per joint, named as in the URDF (without a header: in the "
        "order of the chain), and prints the position of the tip in the base frame, m, row by row. "
        "Without FILE it reads standard input. --offsets applies a calibration with its effects.",
    .example =
        "  echo 0.1,0.2,0.3,-1.5,0.2,1.1,0.4 | mukca fk \\\n"
        "      --urdf data/demo/arm.urdf --pose",
    .with = CLI_WITH_MODEL | CLI_WITH_OFFSETS | CLI_WITH_ACCEPT | CLI_WITH_COLUMNS,
    .options = options,
    .options_size = sizeof(fk_options),
    .reads = CLI_READS_MODEL,
    .table = write_tips,
    .work_size = sizeof(mukca_rows),
};
