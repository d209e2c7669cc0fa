/* mukca compensate: joint targets or poses in, corrected joint targets out. */
#include "arm/compensate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/note.h"
#include "base/number.h"
#include "cli/cli.h"
#include "io/output.h"
#include "io/rows.h"
#include "recalibrate/errors.h"

typedef struct {
    cli_common common;
    bool poses, position_only;
    double tolerance;
} compensate_options;

static const cli_option options[] = {
    CLI_OPTION(
        compensate_options, poses, "poses", CLI_FLAG, NULL,
        "rows are poses (x_m y_m z_m, optionally qw qx qy qz or the rotation vector rx ry rz), not "
        "joint targets"),
    CLI_OPTION(compensate_options, position_only, "position-only", CLI_FLAG, NULL,
               "ignore the orientation (always with fewer than six joints)"),
    CLI_OPTION(compensate_options, tolerance, "tolerance", CLI_POSITIVE, "M",
               "error at which a target counts as reached, m and rad (default: 1e-8)"),
    CLI_OFFSETS_OPTION,
    CLI_ACCEPT_OPTION,
    CLI_MODEL_OPTIONS,
    CLI_UNITS_OPTION,
    CLI_JSON_OPTION,
    CLI_OUTPUT_OPTION("write the corrected targets there (default: standard output)"),
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS};

typedef struct {
    mukca_moments before, after;
    long count[MUKCA_REACH_COUNT], rows;
} tally;

static void print_header(FILE *stream, const mukca_chain *chain, bool timed)
{
    if (timed) fputs("time_s\t", stream);
    for (int j = 0; j < chain->n_joints; j++)
        fprintf(stream, "%s\t", mukca_chain_joint_name(chain, j));
    fputs("error_before_m\terror_m\terror_rad\tstatus\n", stream);
}

static void print_row(FILE *stream, const double *q, int n, const mukca_compensation *c)
{
    for (int j = 0; j < n; j++) fprintf(stream, "%.17g\t", q[j]);
    fprintf(stream, "%.9g\t%.9g\t%.9g\t%s\n", c->position_before, c->position_error,
            c->rotation_error, mukca_reach_text[c->reach]);
}

static void count(tally *t, const mukca_compensation *c)
{
    t->rows++;
    t->count[c->reach]++;
    mukca_moments_add(&t->before, c->position_before);
    mukca_moments_add(&t->after, c->position_error);
}

static mukca_status from_joints(cli_call *call, FILE *stream, tally *t, const mukca_corrected *arm,
                                const char *path, bool first)
{
    const compensate_options *o = call->options;
    mukca_compensator compensator;
    mukca_rows rows;
    mukca_row row;
    mukca_rows_options header = {.kind = MUKCA_EITHER, .note = cli_note, .context = call};
    mukca_status status = cli_read_format(call, &header.format);
    if (status == MUKCA_OK)
        status = mukca_rows_open(&rows, path, &arm->chain, &header, &call->error);
    if (status != MUKCA_OK) return status;
    mukca_compensator_start(&compensator, arm, o->position_only, o->tolerance);
    if (first) print_header(stream, &arm->chain, rows.column.time >= 0);
    while (!ferror(stream)) {
        bool more;
        status = mukca_rows_next(&rows, &row, &more, &call->error);
        if (status != MUKCA_OK || !more) break;
        if (cli_interrupted()) status = MUKCA_INTERRUPTED;
        if (status != MUKCA_OK) break;
        const mukca_row_reading reading = mukca_row_read(&row, &rows);
        mukca_compensation c = mukca_compensate_joints(row.q, &compensator, &reading);
        if (rows.column.time >= 0) fprintf(stream, "%.17g\t", row.time);
        print_row(stream, row.q, arm->chain.n_joints, &c);
        count(t, &c);
    }
    mukca_rows_close(&rows);
    return status;
}

/* The columns of a table of poses: the position, and one way to give the orientation. */
enum { POSE_PLACES = 10 };
static const char *const pose_names[POSE_PLACES] = {"x_m", "y_m", "z_m", "qw", "qx",
                                                    "qy",  "qz",  "rx",  "ry", "rz"};
typedef struct {
    mukca_table table;
    int column[POSE_PLACES];
    int first, end; /* of the orientation's columns: 3 to 7, 7 to 10, or none */
} pose_table;

static mukca_status open_poses(pose_table *p, const char *path, cli_call *call)
{
    mukca_table *t = &p->table;
    mukca_status status = mukca_table_open(t, path, MUKCA_HEADER, &call->error);
    if (status != MUKCA_OK) return status;
    if (mukca_table_find(t, "qw") >= 0)
        p->first = 3, p->end = 7;
    else if (mukca_table_find(t, "rx") >= 0)
        p->first = 7, p->end = 10;
    for (int i = 0; i < POSE_PLACES && status == MUKCA_OK; i++)
        if (i < 3 || (i >= p->first && i < p->end))
            status = mukca_table_require(&p->column[i], t, pose_names[i], &call->error);
    if (status != MUKCA_OK) return status;
    char list[160] = "";
    int unknown = 0;
    for (int c = 0; c < t->n_columns; c++) {
        bool known = false;
        for (int i = 0; i < POSE_PLACES; i++) known |= strcmp(t->header[c], pose_names[i]) == 0;
        const size_t used = strlen(list);
        if (known) continue;
        snprintf(list + used, sizeof list - used, "%s%s", unknown++ ? ", " : "", t->header[c]);
    }
    if (unknown)
        mukca_note_format(cli_note, call, "%s: %d unknown column%s ignored: %s",
                          mukca_file_shown(path), unknown, unknown > 1 ? "s" : "", list);
    return MUKCA_OK;
}

static mukca_status read_pose(mukca_frame *target, const pose_table *p, mukca_error *error)
{
    const mukca_table *table = &p->table;
    double v[POSE_PLACES];
    for (int i = 0; i < POSE_PLACES; i++) {
        if (i >= 3 && (i < p->first || i >= p->end)) continue;
        mukca_status status = mukca_table_number(&v[i], table, p->column[i], error);
        if (status != MUKCA_OK) return status;
        if (fabs(v[i]) > MUKCA_NUMBER_LARGEST)
            return mukca_table_fail(error, table, p->column[i], "%g is no %s", v[i],
                                    i < 3 ? "position; give m" : "rotation; give rad");
    }
    memcpy(target->p, v, sizeof target->p);
    if (p->first == 7) mukca_rotation_exp(target->R, v + 7);
    if (p->first != 3) return MUKCA_OK;
    if (!mukca_rows_normalise(v + 3))
        return mukca_table_fail(error, table, p->column[3],
                                "the quaternion's length is not 1 (order: qw qx qy qz)");
    mukca_rotation_from_quaternion(target->R, v + 3);
    return MUKCA_OK;
}

static mukca_status from_poses(cli_call *call, FILE *stream, tally *t, const mukca_corrected *arm,
                               const char *path, bool first)
{
    const compensate_options *o = call->options;
    mukca_compensator compensator;
    pose_table poses = {0};
    double q[MUKCA_MAX_JOINTS] = {0};
    mukca_status status = open_poses(&poses, path, call);
    if (status == MUKCA_OK && first) print_header(stream, &arm->chain, false);
    mukca_compensator_start(&compensator, arm, o->position_only || poses.first == 0, o->tolerance);
    while (status == MUKCA_OK && !ferror(stream)) {
        bool more;
        mukca_frame target;
        status = mukca_table_next(&poses.table, &more, &call->error);
        if (status != MUKCA_OK || !more) break;
        if (cli_interrupted()) status = MUKCA_INTERRUPTED;
        if (status == MUKCA_OK) status = read_pose(&target, &poses, &call->error);
        if (status != MUKCA_OK) break;
        const mukca_row_reading reading = {
            .time = (double)NAN, .placement = -1, .number = poses.table.row};
        mukca_compensation c = mukca_compensate_pose(q, &compensator, &target, &reading);
        print_row(stream, q, arm->chain.n_joints, &c);
        count(t, &c);
    }
    mukca_table_close(&poses.table);
    return status;
}

static void print_tally(cli_call *call, const tally *t, bool poses)
{
    if (t->rows == 0) return;
    if (poses)
        cli_answer(call, "%ld rows: error %.6f mm mean, %.6f mm at most\n", t->rows,
                   1e3 * t->after.mean, 1e3 * t->after.max);
    else
        cli_answer(call, "%ld row%s: error %.4f mm (mean), %.4f mm (max) -> %.4f mm, %.4f mm\n",
                   t->rows, t->rows == 1 ? "" : "s", 1e3 * t->before.mean, 1e3 * t->before.max,
                   1e3 * t->after.mean, 1e3 * t->after.max);
    for (int r = 1; r < MUKCA_REACH_COUNT; r++)
        if (t->count[r] > 0)
            cli_answer(call, "%ld rows '%s': %s\n", t->count[r], mukca_reach_text[r],
                       mukca_reach_sentence[r]);
}

static json_t *as_json(const cli_call *call, const tally *t)
{
    json_t *counts = json_object();
    for (int r = 0; r < MUKCA_REACH_COUNT; r++)
        json_object_set_new(counts, mukca_reach_text[r], json_integer((json_int_t)t->count[r]));
    return json_pack("{s:s, s:I, s:o, s:o, s:o, s:f}", "schema", "mukca.compensate/1", "rows",
                     (json_int_t)t->rows, "before",
                     cli_json_numbers("mean_m", t->before.mean, "max_m", t->before.max), "after",
                     cli_json_numbers("mean_m", t->after.mean, "max_m", t->after.max), "status",
                     counts, "elapsed_s", cli_elapsed(call));
}

static mukca_status run(cli_call *call)
{
    const compensate_options *o = call->options;
    const cli_common *c = call->common;
    const cli_model *model = &call->session->model;
    mukca_corrected *arm = call->work;
    mukca_output output = {0};
    tally t = {.rows = 0};
    mukca_status status = cli_check_outputs(call);
    if (status == MUKCA_OK) status = cli_load_model(call, &call->session->model);
    if (status != MUKCA_OK) return status;
    arm->chain = model->chain;
    arm->geometry = model->geometry;
    arm->n_effects = model->offsets.n_effects;
    memcpy(arm->effects, model->offsets.effects, sizeof arm->effects);
    if (!c->offsets)
        cli_note(call, "no --offsets: targets are those of the nominal model; no correction");
    const bool json_only = c->json && strcmp(c->json, "-") == 0 && !c->output;
    status = json_only ? mukca_output_open(&output, "/dev/null", true, &call->error)
                       : cli_output_open(call, &output);
    const cli_list input = status == MUKCA_OK ? cli_inputs(call) : (cli_list){0};
    for (int i = 0; i < input.n && status == MUKCA_OK; i++)
        status = o->poses ? from_poses(call, output.stream, &t, arm, input.items[i], i == 0)
                          : from_joints(call, output.stream, &t, arm, input.items[i], i == 0);
    status = mukca_output_finish(&output, status, &call->error);
    if (status != MUKCA_OK) return status;
    print_tally(call, &t, o->poses);
    return c->json ? cli_write_json(call, as_json(call, &t)) : MUKCA_OK;
}

const cli_command cli_command_compensate = {
    .name = "compensate",
    .group = CLI_USE,
    .summary = "correct joint targets for the identified errors",
    .synopsis = "[FILE...]",
    .max_arguments = -1,
    .description =
        "For controllers whose model cannot be changed. Reads rows of joint targets (with --poses: "
        "of poses in the base frame) and writes corrected joint targets: with these the arm of "
        "--offsets, effects included, reaches what the nominal model meant. Damped least squares "
        "with the smallest change of the joints, within their limits; along a path the corrections "
        "are continuous. For a target out of reach the row holds the nearest solution, and its "
        "status says why.",
    .example =
        "echo 0.1,0.2,0.3,-1.5,0.2,1.1,0.4 | mukca compensate --urdf data/demo/arm.urdf --offsets "
        "build/demo/offsets.tsv",
    .options = options,
    .options_size = sizeof(compensate_options),
    .run = run,
    .work_size = sizeof(mukca_corrected),
};
