/* mukca export: the calibrated model in other formats. */

#include "io/export.h"
#include "cli/cli.h"

typedef struct {
    cli_common common;
    const char *into, *motion;
    int format;
} export_options;

static const char *const formats[] = {
#define FORMAT_NAME(name, endings, description) #name,
    MUKCA_EXPORT_LIST(FORMAT_NAME)
#undef FORMAT_NAME
        NULL};

static const cli_option options[] = {
    CLI_OPTION(export_options, format, "format", CLI_CHOICE, "FORMAT",
               "what to write (default: by the ending of the file's name, else urdf)",
               .choices = formats, .letter = 'f'),
    CLI_OPTION(export_options, into, "into", CLI_TEXT, "FILE",
               "your own URDF or MuJoCo model: replace the poses of the arm, found by names",
               .excludes = "format"),
    CLI_OPTION(export_options, motion, "motion", CLI_INPUT, "FILE",
               "the table of mukca motion: patch friction, armature and masses, in the model of "
               "--into (default: the URDF), instead of poses",
               .excludes = "format offsets"),
    CLI_OUTPUT_OPTION("where to write it (default: standard output)"),
    {.name = NULL}};

static const export_options defaults = {.format = -1};

/* -1: unknown. */
static int find_format(const cli_call *call)
{
    const export_options *o = call->options;
    return o->into || o->motion ? 0
           : o->format < 0      ? mukca_exporter_find(call->common->output)
                                : o->format;
}

static mukca_status check(cli_call *call)
{
    if (find_format(call) >= 0) return MUKCA_OK;
    return cli_fail(call, MUKCA_USAGE,
                    "%.100s: no format has this ending; choose one with --format (for SDF: write a "
                    "URDF, then gz sdf -p FILE.urdf)",
                    call->common->output);
}

static mukca_status run(cli_call *call)
{
    cli_session *s = call->session;
    /* while the chain still has the factory's origins */
    MUKCA_TRY(cli_load_data(call, &s->data, &s->model, &call->arguments));
    s->model.chain = s->model.urdf; /* the exported origins replace the URDF's */
    return MUKCA_OK;
}

static mukca_status write_model(cli_call *call, FILE *stream)
{
    static const mukca_exporter into = {"the model of --into", "", &mukca_export_into},
                                motion = {"the model", "", &mukca_export_motion};
    const export_options *o = call->options;
    const cli_arm *c = &call->common->arm;
    const cli_session *s = call->session;
    const mukca_export_input input = {.urdf_path = c->urdf,
                                      .offsets_path = c->offsets,
                                      .chain = &s->model.chain,
                                      .offsets = &s->model.offsets,
                                      .kinematics = c->kinematics ? &s->model.kinematics : NULL,
                                      .postures = s->data.q,
                                      .n_postures = s->data.n_rows,
                                      .into = o->into,
                                      .motion = o->motion,
                                      .other_arm = call->common->accept_other_arm,
                                      .notes = cli_notes(call),
                                      .error = &call->error};
    return mukca_export_write(stream,
                              o->motion ? &motion
                              : o->into ? &into
                                        : &mukca_exporters[find_format(call)],
                              &input);
}

#define FORMAT_LINE(name, endings, description) "  " #name " (" endings "): " description "\n"

const cli_command cli_command_export = {
    .name = "export",
    .group = CLI_USE,
    .summary = "the calibrated model in the formats of others",
    .synopsis = "[DATA...]",
    .description =
        "Writes the model that --urdf and --offsets describe. A URDF is patched in place: the "
        "origins of the chain's joints get the calibrated values, every other byte stays as it "
        "was.\n\n"
        "Calibrated values replace the nominal ones: calibrated = nominal + offset, in the frame "
        "and with the signs of the URDF's own origin. Nothing is subtracted. Offsets below 1e-9 m "
        "or rad count as zero.\n\n"
        "--into patches a URDF of your own, whose joints have the names (a common prefix may be "
        "missing) and the origins of the URDF's joints, or a MuJoCo model, whose bodies have the "
        "names of its links and, at zero, the axes of its joints. The frames of the bodies may "
        "differ from those of the links.\n\n"
        "--motion sets friction and damping of the joints, in a MuJoCo model their armature too, "
        "and the inertial of links, to the values that mukca motion found: of each finding its "
        "most probable effect, if its probability is 50 % or more. Notes state each change, and "
        "what the model cannot represent.\n\n"
        "A format that cannot hold an effect of the table gets origins that were fitted to the arm "
        "with its effects, over its joint ranges or over the postures of DATA; a note states what "
        "is lost. npy holds offsets of the joints' zeros alone, fitted likewise.\n\n"
        "Formats, with the endings of their files:\n" MUKCA_EXPORT_LIST(FORMAT_LINE),
    .example =
        "  mukca export --urdf data/demo/arm.urdf \\\n"
        "      --offsets build/demo/offsets.tsv --format yaml",
    .with = CLI_WITH_MODEL | CLI_WITH_OFFSETS | CLI_WITH_ACCEPT | CLI_WITH_TABLES,
    .options = options,
    .options_size = sizeof(export_options),
    .defaults = &defaults,
    .check = check,
    .reads = CLI_READS_MODEL,
    .run = run,
    .table = write_model,
};
