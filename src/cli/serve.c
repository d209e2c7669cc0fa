/* `mukca serve`: capture, calibrate and diagnose as a daemon, driven over LCM. */
#include <stdio.h>
#include <stdlib.h>

#include "cli/live.h"
#include "record/server.h"

typedef struct {
    cli_common common;
    cli_live live;
    mukca_server_options server;
} serve_options;

/* Arms are built to some 10 mm: a larger change indicates a damaged or another arm, or wrong
 * samples. */
static const serve_options defaults = {.server.most_change = 10e-3};

typedef struct {
    mukca_server server;
    cli_relay relay;
    bool quiet;
} serve_work;

static void report(void *context, const char *line)
{
    serve_work *w = context;
    char text[MUKCA_RECORDER_LINE + 1];
    snprintf(text, sizeof text, "%s\n", line);
    if (!w->quiet) cli_relay_write(&w->relay, text);
}

static void conclude(cli_call *call, const mukca_server *s)
{
    cli_log(call, "stopped; %lld joint states received, %lld messages refused\n",
            (long long)s->recorder.stream.count.received,
            (long long)s->recorder.stream.count.refused);
    if (s->pose.sent) cli_log(call, "%lld poses sent\n", (long long)s->pose.sent);
}

static mukca_status check(cli_call *call)
{
    mukca_server_options *options = &((serve_options *)call->options)->server;
    if (!options->folder) options->folder = getenv("STATE_DIRECTORY");
    if (options->folder && *options->folder) return MUKCA_OK;
    return cli_fail(call, MUKCA_USAGE,
                    "--state DIR is needed: the folder of sessions, results and state");
}

static mukca_status run(cli_call *call)
{
    serve_options *o = call->options;
    serve_work *w = call->work;
    mukca_server *s = &w->server;
    const cli_model *model = &call->session->model;
    mukca_server_options *options = &o->server;
    const mukca_recorder_hooks hooks = {.report = {report, w}, .interrupted = cli_interrupted};
    w->quiet = call->common->quiet;
    o->live.recorder.triggers = true;
    cli_live_complete(&o->live, call->common);
    options->recorder = o->live.recorder;
    cli_live_arguments(options->arguments, call);
    MUKCA_TRY(
        mukca_server_open(s, options, &model->chain, model->offsets.theta, &hooks, &call->error));
    cli_relay_open(&w->relay);
    const mukca_status status = mukca_server_run(s, &call->error);
    cli_relay_close(&w->relay);
    conclude(call, s);
    return status;
}

static void release(void *work)
{
    mukca_server_close(&((serve_work *)work)->server);
}

static const cli_option options[] = {
    CLI_LIVE_OPTIONS(serve_options),
    CLI_OPTION(serve_options, server.folder, "state", CLI_TEXT, "DIR",
               "folder of sessions, results and state (default: systemd's STATE_DIRECTORY)"),
    CLI_OPTION(serve_options, server.publish_pose, "publish-pose", CLI_FLAG, NULL,
               "send the calibrated pose of the tip for each joint state on MUKCA_POSE"),
    CLI_OPTION(
        serve_options, server.most_change, "most-change", CLI_POSITIVE, "M",
        "largest change of the tip that use makes against the table in use, m (default: 0.01)"),
    CLI_OPTION(
        serve_options, server.accept, "accept", CLI_TEXT, "LIST",
        "commands to accept over LCM, commas between; trigger: messages on MUKCA_TRIGGER; reopen: "
        "start of a finished session; all (default: all but delete, use and reopen)"),
    {.name = NULL}};

const cli_command cli_command_serve = {
    .name = "serve",
    .group = CLI_MEASURE,
    .summary = "record, calibrate and diagnose as a daemon driven over LCM",
    .synopsis = "",
    .description =
        "Listens to the joint states of the robot and to commands on MUKCA_COMMAND (`mukca send` "
        "sends them). It records sessions, calibrates and diagnoses. It sends its status twice a "
        "second on MUKCA_STATUS, samples on MUKCA_SAMPLE and results on MUKCA_RESULT; a message on "
        "MUKCA_TRIGGER records a sample. The message types are in data/lcm (installed: "
        "share/mukca/lcm). After a restart it resumes its session, unless that was finished; "
        "SIGTERM ends it cleanly. The folder of --state holds sessions/NAME.tsv, results/NAME.* "
        "and state.tsv. One server uses it at a time; a second one ends with exit code 3.\n\n"
        "Commands:\n"
#define VERB_HELP(name, usage, arguments, sentence) "  " #name usage "\n      " sentence "\n"
    MUKCA_SERVER_VERB_LIST(VERB_HELP)
#undef VERB_HELP
        "\nWith --publish-pose each joint state is answered by the pose of the tip, computed with "
        "the table in use, for controllers that cannot load a URDF. Joint drift is not included. A "
        "calibration or diagnosis does not change the table in use: the command use does, if the "
        "result is accepted (see calibrate), its error on the samples of its session and of that "
        "of the table in use is not larger than that table's, and the tip moves by at most "
        "--most-change. The table in use is kept across restarts.",
    .example =
        "  mukca serve --urdf data/demo/arm.urdf \\\n"
        "      --lcm-url file://data/demo/guided.lcmlog --state build/served",
    .with = CLI_WITH_MODEL | CLI_WITH_DISTANCE | CLI_WITH_DISTANCES | CLI_WITH_SD | CLI_WITH_TRAITS,
    .options = options,
    .options_size = sizeof(serve_options),
    .defaults = &defaults,
    .check = check,
    .reads = CLI_READS_MODEL,
    .run = run,
    .work_size = sizeof(serve_work),
    .release = release,
};
