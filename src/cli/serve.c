/* `mukca serve`: capture, calibrate and diagnose as a daemon, driven over LCM. */
#include "cli/serve.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const double publish_period = 0.5;

/* ---- verbs ---- */

typedef mukca_status verb_fn(server *s, const mukca_message_command *command,
                             char line[RECORDER_LINE]);

static const char *argument(const mukca_message_command *command, int i)
{
    return i < command->n ? command->argument[i] : NULL;
}

/* Remember where the session stands. */
static void keep_place(server *s)
{
    const recorder *r = &s->engine;
    if (!r->session.fd) return;
    snprintf(s->memory.placement, sizeof s->memory.placement, "%s",
             mukca_capture_placement(&r->capture));
    snprintf(s->memory.socket, sizeof s->memory.socket, "%s", mukca_capture_socket(&r->capture));
    snprintf(s->memory.rows, sizeof s->memory.rows, "%d", r->session.n_rows);
}

/* Begin or resume the session that the memory names, once the stream is known. */
static mukca_status begin(server *s)
{
    char path[SERVE_PATH], line[RECORDER_LINE];
    recorder *r = &s->engine;
    if (s->session_begun || !s->memory.session[0] || !r->connected) return MUKCA_OK;
    serve_path(path, s, s->memory.session, ".tsv");
    s->session_begun = true;
    mukca_status status = recorder_begin(r, path, true, false);
    if (status) {
        recorder_say(r, "%s", s->call->error.text);
        return status;
    }
    /* a row that came after the last save says where the session stands, too */
    if (s->memory.placement[0] && strtol(s->memory.rows, NULL, 10) == r->session.n_rows)
        recorder_select(r, s->memory.placement, s->memory.socket, line);
    keep_place(s);
    recorder_say(r, "session %s: %d rows", path, r->session.n_rows);
    return MUKCA_OK;
}

static mukca_status do_start(server *s, const mukca_message_command *command,
                             char line[RECORDER_LINE])
{
    recorder *r = &s->engine;
    const char *name = argument(command, 0) ? argument(command, 0) : "session";
    snprintf(line, RECORDER_LINE, "a session's name: at most 40 letters, digits, _ - and .");
    if (!serve_name_ok(name)) return MUKCA_USAGE;
    snprintf(line, RECORDER_LINE, "no joint states yet: %.200s",
             r->problem.status ? r->problem.text : "is the robot's driver running?");
    if (!r->connected) return MUKCA_TRANSPORT;
    serve_memory before = s->memory;
    memset(&s->memory, 0, offsetof(serve_memory, model));
    snprintf(s->memory.session, sizeof s->memory.session, "%s", name);
    s->session_begun = false;
    mukca_status status = begin(s);
    snprintf(line, RECORDER_LINE, "%s", status ? s->call->error.text : r->last_line);
    if (status) {
        s->memory = before;
        s->session_begun = false; /* go on with the old one */
        (void)begin(s);
    }
    return status;
}

static mukca_status do_add(server *s, const mukca_message_command *command,
                           char line[RECORDER_LINE])
{
    return recorder_take(&s->engine, command->id, argument(command, 0), argument(command, 1), line);
}

static mukca_status do_delete(server *s, const mukca_message_command *command,
                              char line[RECORDER_LINE])
{
    (void)command;
    return recorder_undo(&s->engine, line);
}

static mukca_status do_socket(server *s, const mukca_message_command *command,
                              char line[RECORDER_LINE])
{
    if (!argument(command, 0)) return recorder_other_socket(&s->engine, line);
    return recorder_select(&s->engine, NULL, argument(command, 0), line);
}

static mukca_status do_placement(server *s, const mukca_message_command *command,
                                 char line[RECORDER_LINE])
{
    if (!argument(command, 0)) return recorder_next_placement(&s->engine, line);
    return recorder_select(&s->engine, argument(command, 0), s->engine.capture.settings.labels[0],
                           line);
}

static mukca_status do_finish(server *s, const mukca_message_command *command,
                              char line[RECORDER_LINE])
{
    (void)command;
    recorder *r = &s->engine;
    if (!r->session.fd) {
        snprintf(line, RECORDER_LINE, "no session is being recorded");
        return MUKCA_NEGATIVE;
    }
    snprintf(line, RECORDER_LINE, "%d rows in %.250s", r->session.n_rows, r->session.path);
    mukca_session_close(&r->session);
    return MUKCA_OK;
}

static mukca_status start_job(server *s, bool diagnosis, const mukca_message_command *command,
                              char line[RECORDER_LINE])
{
    mukca_error error;
    mukca_status status = serve_start_job(s, diagnosis, command->id, &error);
    if (status) {
        snprintf(line, RECORDER_LINE, "%s", error.text);
        return status;
    }
    line[0] = '\0'; /* answered when it ends */
    if (mukca_lcm_link_replays(s->engine.link)) serve_finish_job(s, true);
    return MUKCA_OK;
}

static mukca_status do_calibrate(server *s, const mukca_message_command *command,
                                 char line[RECORDER_LINE])
{
    return start_job(s, false, command, line);
}

static mukca_status do_diagnose(server *s, const mukca_message_command *command,
                                char line[RECORDER_LINE])
{
    return start_job(s, true, command, line);
}

static mukca_status do_result(server *s, const mukca_message_command *command,
                              char line[RECORDER_LINE])
{
    if (!s->pose.ready) {
        snprintf(line, RECORDER_LINE, "there is no calibration yet");
        return MUKCA_NEGATIVE;
    }
    char text[RECORDER_LINE];
    snprintf(text, sizeof text, "the table in use: %s", s->memory.model);
    serve_answer(s, command->id, "result", MUKCA_OK, text, &s->pose.offsets, NULL);
    line[0] = '\0';
    return MUKCA_OK;
}

/* verb, usage, most arguments, sentence */
#define VERB_LIST(X)                                                                    \
    X(start, " [NAME]", 1, "begin the session NAME, or go on with it")                  \
    X(add, " [PLACEMENT [SOCKET]]", 2, "take a sample now")                             \
    X(delete, "", 0, "take the last row back")                                          \
    X(socket, " [LABEL]", 1, "go on with that socket, or the other one")                \
    X(placement, " [NAME]", 1, "go on with that placement, or a new one")               \
    X(finish, "", 0, "close the session")                                               \
    X(calibrate, "", 0, "calibrate on the session; the result holds the offsets table") \
    X(diagnose, "", 0, "diagnose the session; the result adds what effects were found") \
    X(result, "", 0, "send the table that is in use")

const char *const serve_verbs[] = {
#define VERB_NAME(name, usage, arguments, sentence) #name,
    VERB_LIST(VERB_NAME)
#undef VERB_NAME
        NULL};

static const struct {
    const char *name;
    int arguments;
    verb_fn *run;
} verbs[] = {
#define VERB_ROW(name, usage, arguments, sentence) {#name, arguments, do_##name},
    VERB_LIST(VERB_ROW)
#undef VERB_ROW
};

static void on_packet(void *context, const mukca_lcm_packet *packet)
{
    server *s = context;
    mukca_message_command command;
    mukca_error error;
    char line[RECORDER_LINE] = "";
    if (mukca_message_decode(&command, MUKCA_MESSAGE_COMMAND, packet->data, packet->size, &error)) {
        recorder_refuse(&s->engine, RECORDER_OWN_MESSAGE, "%s: %s: ignored", packet->channel,
                        error.text);
        return;
    }
    mukca_status status = MUKCA_USAGE;
    snprintf(line, sizeof line, "unknown verb or too many arguments: \"%.40s\"", command.verb);
    for (size_t i = 0; i < sizeof verbs / sizeof verbs[0]; i++)
        if (strcmp(command.verb, verbs[i].name) == 0 && command.n <= verbs[i].arguments)
            status = verbs[i].run(s, &command, line);
    keep_place(s);
    if (serve_save(s, &error) && !status) {
        status = error.status;
        snprintf(line, sizeof line, "%s", error.text);
    }
    if (!line[0]) return;
    serve_answer(s, command.id, command.verb, status, line, NULL, NULL);
    recorder_say(&s->engine, "%.40s: %s", command.verb, line);
}

/* ---- the daemon ---- */

static void say(void *context, const char *line)
{
    server *s = context;
    cli_say(s->call, "%s\n", line);
}

static mukca_status loop(server *s)
{
    recorder *r = &s->engine;
    mukca_status status = MUKCA_OK;
    char last[RECORDER_LINE] = "";
    mukca_error error;
    bool unsaved = false;
    while (!cli_interrupted()) {
        status = recorder_step(r, 100, -1, NULL);
        if (status) break;
        if (r->mapped && !r->confirmed) { /* by order, and nobody has said so */
            mukca_fail(&r->problem, MUKCA_USAGE,
                       "%s sends no joint names: start serve with --map order", r->channel);
        }
        if (r->problem.status && strcmp(last, r->problem.text) != 0)
            recorder_say(r, "%s", r->problem.text);
        snprintf(last, sizeof last, "%s", r->problem.status ? r->problem.text : "");
        (void)begin(s); /* has said what is wrong */
        serve_finish_job(s, false);
        double now = cli_elapsed(s->call);
        if (now - s->published < publish_period) continue;
        keep_place(s);
        bool failed = serve_save(s, &error) != MUKCA_OK;
        if (failed && !unsaved) recorder_say(r, "%s", error.text);
        unsaved = failed;
        recorder_publish_status(r,
                                s->job.child ? s->job.diagnosis ? "diagnose" : "calibrate" : NULL);
        serve_notify("WATCHDOG=1");
        s->published = now;
    }
    return status == MUKCA_NEGATIVE ? MUKCA_OK : status; /* the log's end */
}

static mukca_status check_usage(server *s)
{
    mukca_error *error = &s->call->error;
    s->folder = s->options->state ? s->options->state : getenv("STATE_DIRECTORY");
    if (!s->folder || !*s->folder)
        return mukca_fail(error, MUKCA_USAGE,
                          "--state DIR is needed: where sessions, results and state are kept");
    if (mkdir(s->folder, 0777) && errno != EEXIST)
        return mukca_fail(error, MUKCA_INPUT, "--state %s: %s", s->folder, strerror(errno));
    if (access(s->folder, R_OK | W_OK | X_OK))
        return mukca_fail(error, MUKCA_INPUT, "--state %s: must be a folder that can be written",
                          s->folder);
    return MUKCA_OK;
}

static mukca_status run(cli_call *call)
{
    server *s = calloc(1, sizeof *s);
    if (!s) return mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
    s->call = call;
    s->options = call->options;
    recorder_hooks hooks = {.say = say,
                            .packet = on_packet,
                            .joints = s->options->publish_pose ? serve_send_pose : NULL,
                            .context = s};
    mukca_status status = check_usage(s);
    if (!status) status = cli_load_model(call, &s->model);
    if (!status)
        status = recorder_open(&s->engine, call, &s->options->recorder, &s->model, true, &hooks);
    if (!status) status = serve_remember(s);
    if (status) goto out;
    mukca_row_state_stream(&s->pose.states, s->model.chain.n_joints);
    mukca_message_channel(s->pose.channel, MUKCA_MESSAGE_POSE, s->options->recorder.prefix);
    mukca_error error;
    if (serve_load_model(s, &error)) recorder_say(&s->engine, "%s", error.text);
    if (mukca_lcm_link_replays(s->engine.link)) status = recorder_connect(&s->engine, -1);
    if (!status) status = recorder_keep_log(&s->engine);
    if (status) goto out;
    serve_notify("READY=1");
    status = loop(s);
    serve_notify("STOPPING=1");
    serve_kill_job(s);
    recorder_publish_status(&s->engine, "stopped");
    cli_say(call, "stopped; %lld joint states received, %lld messages refused\n",
            (long long)s->engine.received, (long long)s->engine.refused);
    if (s->pose.sent)
        cli_say(call, "%lld poses sent; from reception to sent: median %.0f us, 99.9 %% %.0f us\n",
                (long long)s->pose.sent, 1e6 * serve_latency(&s->pose, 0.5),
                1e6 * serve_latency(&s->pose, 0.999));
out:
    recorder_close(&s->engine);
    free(s);
    return status;
}

#define AT(kind, name, argument, member, help)                               \
    {                                                                        \
        name, 0, kind, argument, help, NULL, offsetof(serve_options, member) \
    }

static const cli_option options[] = {
    CLI_MODEL_OPTIONS,
    RECORDER_OPTIONS(serve_options),
    AT(CLI_TEXT, "state", "DIR", state,
       "folder of sessions, results and state (default: systemd's STATE_DIRECTORY)"),
    AT(CLI_FLAG, "publish-pose", NULL, publish_pose,
       "send the calibrated pose of the tip for each joint state on MUKCA_POSE"),
    CLI_DISTANCE_OPTIONS,
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS,
};

const cli_command cli_command_serve = {
    .name = "serve",
    .group = CLI_MEASURE,
    .summary = "do the whole job as a daemon that is driven over LCM",
    .synopsis = "",
    .description =
        "Listens to the robot's joint states and to commands on MUKCA_COMMAND (`mukca send` sends "
        "them), records sessions, calibrates and diagnoses, and sends its status twice a second on "
        "MUKCA_STATUS, samples on MUKCA_SAMPLE and results on MUKCA_RESULT. Messages on "
        "MUKCA_TRIGGER take a sample. The message types lie in data/lcm (installed: "
        "share/mukca/lcm). It goes on where it was "
        "after a restart; SIGTERM ends it cleanly.\n\n"
        "Commands:\n"
#define VERB_HELP(name, usage, arguments, sentence) "  " #name usage "\n      " sentence "\n"
    VERB_LIST(VERB_HELP)
#undef VERB_HELP
        "\nWith --publish-pose each joint state is answered by the pose of the tip by the last "
        "calibration (and diagnosis), for controllers that cannot load a URDF. Effects that depend "
        "on the recording's order or time are left out of it.",
    .example =
        "mukca serve --urdf data/demo/arm.urdf --lcm-url file://data/demo/guided.lcmlog "
        "--state build/served",
    .options = options,
    .options_size = sizeof(serve_options),
    .run = run,
};
