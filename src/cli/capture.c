/* `mukca capture`: record a session from LCM, triggered by key, LCM message or standstill. */
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/text.h"
#include "cli/live.h"
#include "io/output.h"
#include "lcm/type.h"

typedef struct {
    cli_common common;
    cli_live live;
    bool resume;
    int rows;
    double wait;
} capture_options;

typedef struct {
    mukca_recorder recorder;
    cli_call *call;
    const capture_options *options;
    int keys;  /* terminal to read keys from; -1: none */
    bool view; /* standard error is a terminal */
    cli_capture_view terminal;
    double redrawn, published; /* s */
    bool finished;
} capture_work;

static const double redraw_period = 0.1;  /* s; appears smooth */
static const double publish_period = 0.5; /* s; specified in data/lcm/mukca_status.lcm */

/* ---- hooks and keys ---- */

static void report(void *context, const char *line)
{
    capture_work *s = context;
    if (s->call->common->quiet) return;
    cli_capture_print(&s->terminal, line);
    s->redrawn = 0;
}

static mukca_status may_trigger(void *context, const mukca_lcm_packet *packet, mukca_error *error)
{
    const capture_work *s = context;
    (void)packet;
    if (!s->options->rows || s->recorder.session.file.n_rows < s->options->rows) return MUKCA_OK;
    return mukca_fail(error, MUKCA_NEGATIVE, "the session has its %d samples", s->options->rows);
}

static void read_keys(capture_work *s)
{
    char keys[16];
    ssize_t n = read(s->keys, keys, sizeof keys);
    for (ssize_t i = 0; i < n; i++) s->finished |= cli_capture_press(&s->recorder, keys[i]);
    if (n == 0) s->keys = -1; /* hangup: reading on would spin */
}

static mukca_status confirm_map(capture_work *s)
{
    char lines[4096], answer[16] = "";
    mukca_text text = MUKCA_TEXT(lines);
    mukca_recorder *r = &s->recorder;
    mukca_stream_describe_map(&text, r);
    cli_log(s->call, "%s", lines);
    if (r->stream.map.confirmed) return MUKCA_OK;
    if (s->keys < 0)
        return cli_fail(s->call, MUKCA_USAGE,
                        "%s sends no joint names; if the mapping above is right, add --map order",
                        r->stream.channel);
    fputs("Is that right? [y/n] ", stderr);
    fflush(stderr);
    if (read(s->keys, answer, sizeof answer - 1) <= 0 || (answer[0] != 'y' && answer[0] != 'Y'))
        return cli_fail(s->call, MUKCA_USAGE,
                        "not confirmed: give the readings' numbers, as in --map 8-14");
    r->stream.map.confirmed = true;
    return MUKCA_OK;
}

/* ---- the session ---- */

static mukca_status loop(capture_work *s)
{
    mukca_recorder *r = &s->recorder;
    mukca_status status = MUKCA_OK;
    s->terminal.rows = r->session.file.n_rows;
    while (!s->finished) {
        bool readable;
        status = mukca_recorder_step(r, s->view ? 50 : 200, s->keys, &readable, &s->call->error);
        if (status != MUKCA_OK) break;
        if (readable) read_keys(s);
        if (cli_interrupted() && !r->session.file.n_rows)
            return cli_fail(s->call, MUKCA_INTERRUPTED, "interrupted; no sample was recorded");
        if (cli_interrupted())
            return cli_fail(s->call, MUKCA_INTERRUPTED,
                            "interrupted; %d samples are safe in %s (--resume continues)",
                            r->session.file.n_rows, r->session.file.path);
        double now = cli_elapsed(s->call);
        if (now - s->published >= publish_period) {
            mukca_sampling_publish_status(r, NULL);
            s->published = now;
        }
        if (s->view) cli_capture_ring(&s->terminal, r, now);
        if (s->view && now - s->redrawn >= redraw_period) {
            cli_capture_draw(&s->terminal, &s->recorder);
            s->redrawn = now;
        }
        if (s->options->rows && r->session.file.n_rows >= s->options->rows) s->finished = true;
    }
    return status == MUKCA_NEGATIVE ? MUKCA_OK : status; /* end of the log */
}

static json_t *summary_json(const capture_work *s)
{
    const mukca_recorder *r = &s->recorder;
    const mukca_dataset *rows = &r->session.capture.rows;
    json_t *sockets = json_array();
    for (int k = 0; k < rows->n_sockets; k++) {
        double rms;
        int n = mukca_capture_count(&r->session.capture, k);
        mukca_capture_spread(&rms, NULL, &r->session.capture, k);
        if (n)
            cli_json_append(
                sockets, KEY("placement", rows->placements[rows->sockets[k].placement].name),
                KEY("socket", rows->sockets[k].label), KEY("rows", n), KEY("spread_m", rms));
    }
    return cli_json(KEY("session", r->session.file.path), KEY("rows", r->session.file.n_rows),
                    KEY("channel", r->stream.channel), KEY("type", mukca_stream_type(r)),
                    KEY("stream", mukca_recorder_stream(r)),
                    KEY("received", (long)r->stream.count.received),
                    KEY("refused", (long)r->stream.count.refused),
                    KEY("longest_gap_s", r->stream.count.longest_gap), KEY("sockets", sockets),
                    KEY("expected_m", r->session.advice.expected),
                    KEY("more_rows_help", r->session.advice.more_rows_help));
}

/* Is there a placement that a calibration can use: two sockets or more with two samples each? */
static bool is_usable(const mukca_capture *c)
{
    const mukca_dataset *rows = &c->rows;
    for (int p = 0; p < rows->n_placements; p++) {
        int sockets = 0;
        for (int k = 0; k < rows->n_sockets; k++)
            sockets += rows->sockets[k].placement == p && mukca_capture_count(c, k) >= 2;
        if (sockets >= 2) return true;
    }
    return false;
}

/* Print the command that uses this session, with the options that specify the arm. */
static void print_next(const capture_work *s)
{
    const char *words[MUKCA_SERVER_ARGUMENTS];
    char line[4096] = "";
    mukca_text text = MUKCA_TEXT(line);
    if (!is_usable(&s->recorder.session.capture)) {
        cli_say(s->call, "Next",
                "--resume continues: no placement has two sockets with two samples yet");
        return;
    }
    cli_live_arguments(words, s->call);
    for (int i = 0; words[i]; i++) mukca_text_put(&text, " %s", words[i]);
    cli_answer(s->call, "Next    mukca calibrate%s %s -o offsets.tsv\n", line,
               s->recorder.session.file.path);
}

/* Name joints that did not move, and samples too far apart for any arm with its ball in one
 * socket.  False: there are such samples. */
static bool check_samples(const capture_work *s)
{
    const mukca_capture *c = &s->recorder.session.capture;
    double coverage[MUKCA_MAX_JOINTS], largest = 0;
    char line[1024] = "";
    mukca_text text = MUKCA_TEXT(line);
    mukca_capture_coverage(coverage, c);
    for (int j = 0; j < c->chain->n_joints && c->rows.n_rows > 2; j++)
        if (coverage[j] < 1e-3) mukca_text_put(&text, " %s", mukca_chain_joint_name(c->chain, j));
    if (line[0]) cli_say(s->call, "Check", "did not move:%s", line);
    for (int k = 0; k < c->rows.n_sockets; k++) {
        double rms;
        mukca_capture_spread(&rms, NULL, c, k);
        largest = fmax(largest, rms); /* of NaN, too few samples, the other */
    }
    if (largest < 0.5 * c->settings.distance) return true;
    cli_say(s->call, "Check",
            "the consistency error of a socket is %.0f mm, more than half the distance between "
            "sockets: check its labels, --map, --urdf and that all joints are read",
            1e3 * largest);
    return false;
}

static void conclude(capture_work *s)
{
    const mukca_recorder *r = &s->recorder;
    if (r->link.log.skipped)
        cli_log(s->call, "the log is damaged: %lld bytes of it were skipped\n",
                (long long)r->link.log.skipped);
    cli_say(s->call, NULL,
            "%d sample%s%s%s; %lld joint states received, %lld refused, longest pause %.3f s",
            r->session.file.n_rows, r->session.file.n_rows == 1 ? "" : "s",
            r->session.file.n_rows ? " in " : "",
            r->session.file.n_rows ? r->session.file.path : "", (long long)r->stream.count.received,
            (long long)r->stream.count.refused, r->stream.count.longest_gap);
    if (r->session.file.n_rows && check_samples(s)) print_next(s);
}

/* Keys are read from standard input, or from the terminal if standard input delivers joint
 * states. */
static int find_terminal(bool lines)
{
    if (!lines) return isatty(STDIN_FILENO) ? STDIN_FILENO : -1;
    return isatty(STDERR_FILENO) ? open("/dev/tty", O_RDONLY | O_CLOEXEC) : -1;
}

static mukca_status check(cli_call *call)
{
    const capture_options *o = call->options;
    const cli_common *c = call->common;
    capture_work *s = call->work;
    s->call = call;
    s->options = o;
    s->keys = find_terminal(o->live.recorder.lines);
    if (!c->output || strcmp(c->output, "-") == 0)
        return cli_fail(call, MUKCA_USAGE, "-o FILE is needed: the session to record");
    if (s->keys < 0 && !o->live.recorder.triggers && !o->live.recorder.still &&
        !o->live.recorder.lines)
        return cli_fail(
            call, MUKCA_USAGE,
            "without a terminal there are no keys; use --trigger (LCM messages) or --still");
    if (!o->resume && !c->force && access(c->output, F_OK) == 0)
        return cli_fail(call, MUKCA_INPUT,
                        "%s exists; --resume continues it, --force overwrites it", c->output);
    const char *url = o->live.recorder.network.url;
    const char *log = url && strncmp(url, "file://", 7) == 0 ? url + 7 : NULL;
    if (mukca_output_same(log, c->output) || mukca_output_same(log, c->json))
        return cli_fail(call, MUKCA_USAGE, "%.100s is the log; refusing to overwrite it", log);
    if (c->json) return mukca_output_check(c->json, c->force, &call->error);
    return MUKCA_OK;
}

static mukca_status prepare(capture_work *s)
{
    cli_call *call = s->call;
    capture_options *o = call->options;
    const cli_common *c = call->common;
    mukca_recorder *r = &s->recorder;
    const cli_model *model = &call->session->model;
    const mukca_recorder_hooks hooks = {.report = {report, s},
                                        .trigger = may_trigger,
                                        .interrupted = cli_interrupted,
                                        .context = s};
    cli_live_complete(&o->live, c);
    MUKCA_TRY(mukca_recorder_open(r, &o->live.recorder, &model->chain, model->offsets.theta, &hooks,
                                  &call->error));
    MUKCA_TRY(mukca_recorder_connect(r, o->wait, &call->error));
    MUKCA_TRY(confirm_map(s));
    return mukca_sampling_begin(r, c->output, o->resume, c->force, &call->error);
}

static mukca_status run(cli_call *call)
{
    capture_work *s = call->work;
    const char *term = getenv("TERM");
    s->view = isatty(STDERR_FILENO) && !call->common->quiet && term && strcmp(term, "dumb") != 0;
    MUKCA_TRY(prepare(s));
    if (s->keys >= 0) cli_capture_enter(&s->terminal, s->keys);
    cli_relay_open(&s->terminal.relay);
    mukca_status status = loop(s);
    cli_relay_close(&s->terminal.relay);
    if (s->view) cli_capture_draw(&s->terminal, &s->recorder);
    cli_capture_leave(&s->terminal);
    if (status == MUKCA_OK || status == MUKCA_INTERRUPTED) {
        mukca_sampling_publish_status(&s->recorder, "stopped");
        conclude(s);
        const mukca_status written =
            call->common->json ? cli_write_json(call, summary_json(s)) : MUKCA_OK;
        mukca_error lost;
        mukca_status finished = mukca_recorder_finish(&s->recorder, &lost);
        if (written != MUKCA_OK) status = written;
        if (status == MUKCA_OK && finished != MUKCA_OK) {
            call->error = lost;
            status = finished;
        }
    }
    if (status != MUKCA_OK || s->recorder.session.file.n_rows) return status;
    return cli_fail(call, MUKCA_NEGATIVE, "no sample was recorded");
}

static void release(void *work)
{
    capture_work *s = work;
    mukca_recorder_close(&s->recorder);
}

static const cli_option options[] = {
    CLI_OUTPUT_OPTION("the session (TSV, or CSV by its ending)"),
    CLI_LIVE_OPTIONS(capture_options),
    CLI_OPTION(capture_options, live.recorder.triggers, "trigger", CLI_FLAG, NULL,
               "record a sample on each message on MUKCA_TRIGGER"),
    CLI_OPTION(capture_options, live.recorder.lines, "stdin", CLI_FLAG, NULL,
               "joint states come as lines on standard input: CSV with a header, JSON, or `ros2 "
               "topic echo --csv`"),
    CLI_OPTION(capture_options, resume, "resume", CLI_FLAG, NULL, "continue an existing session"),
    CLI_OPTION(capture_options, rows, "rows", CLI_INTEGER, "N",
               "finish when the session has N samples", .least = 1, .most = MUKCA_CAPTURE_MAX_ROWS),
    CLI_OPTION(capture_options, wait, "wait", CLI_POSITIVE, "S",
               "give up without joint states after S seconds (default: 10)"),
    {.name = NULL}};

static const capture_options defaults = {.wait = 10};

const cli_command cli_command_capture = {
    .name = "capture",
    .group = CLI_MEASURE,
    .summary = "record a session from live joint states (LCM, or lines)",
    .synopsis = "",
    .grows = true,
    .description =
        "Listens to the joint states of the robot. A sample is recorded when the arm stands still "
        "with its ball in a socket (--still), when you press a, or on a message on MUKCA_TRIGGER "
        "(--trigger). It is the mean over a window of standing still; a moving arm is refused. "
        "Each sample is on disk before it is acknowledged; once the file is edited, moved or "
        "deleted, samples are refused: finish, then edit, then --resume. A key or message is "
        "refused if the last joint state is older than a window: after a pause of the program or "
        "the stream, hold still and try again.\n\n"
        "Put the ball into socket 0 of the first placement and record some 20 postures, as "
        "different as possible. Do the same in the other socket (press s without --still). Then "
        "press n, move the tool, and start again; three or four placements all around the base are "
        "enough. In a recorded log, --still finds the placements, too. The screen shows the "
        "consistency error at this socket, which a badly seated ball raises, and when more samples "
        "there no longer help.\n\n"
        "Keys: " CLI_CAPTURE_KEYS
        ". The bell rings once for a sample and twice for a refusal.\n\n"
        "Known types of joint states, and where they are usually sent:\n"
#define STATE_HELP(file, type, channel, fingerprint) "  " type ", " channel "\n"
    MUKCA_LCM_STATE_LIST(STATE_HELP)
#undef STATE_HELP
        "\nAny other type works with a description: --type and --position.\n\n"
        "--stdin reads joint states as lines instead: CSV with a header (time_s and the joints as "
        "in a session; joint_1 [deg] for degrees), JSON lines, or what `ros2 topic echo --csv` "
        "prints. Joints are identified by name, in any order. A line {\"trigger\": 1, "
        "\"placement\": \"front\", \"socket\": \"0\"} records a sample; keys come from the "
        "terminal; --trigger listens to LCM, too. Times of a wall clock are compared with those of "
        "keys and messages: lines that a pipe holds back are refused.",
    .example =
        "  mukca capture --urdf data/demo/arm.urdf \\\n"
        "      --lcm-url file://data/demo/guided.lcmlog --trigger \\\n"
        "      -o build/guided.tsv --force\n"
        "  mukca capture --urdf data/demo/arm.urdf --stdin --still \\\n"
        "      -o build/ros.tsv --force <data/demo/joint_states.csv",
    .with = CLI_WITH_MODEL | CLI_WITH_OFFSETS | CLI_WITH_ACCEPT | CLI_WITH_DISTANCE | CLI_WITH_SD |
            CLI_WITH_JSON | CLI_WITH_TRAITS,
    .options = options,
    .options_size = sizeof(capture_options),
    .defaults = &defaults,
    .check = check,
    .reads = CLI_READS_MODEL,
    .run = run,
    .work_size = sizeof(capture_work),
    .release = release,
};
