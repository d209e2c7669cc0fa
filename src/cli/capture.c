/* `mukca capture`: record a session from LCM, triggered by key, by LCM message, or by standing
 * still. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "io/output.h"
#include "lcm/state.h"
#include "record/recorder.h"

typedef struct {
    cli_common common;
    recorder_options recorder;
    bool trigger, resume;
    int rows;
    double wait;
} capture_options;

typedef struct {
    recorder engine; /* first: hooks get the session */
    cli_call *call;
    const capture_options *options;
    bool keys, view; /* standard input and standard error are terminals */
    struct termios saved;
    bool raw;                  /* the terminal is in our mode */
    int drawn;                 /* lines of the view on the screen */
    double redrawn, published; /* s */
    bool finished;
} session;

static const double redraw_period = 0.1, publish_period = 0.5;

/* ---- the terminal ---- */

static void enter_raw(session *s)
{
    if (!s->keys || tcgetattr(STDIN_FILENO, &s->saved)) return;
    struct termios raw = s->saved;
    raw.c_lflag &= ~(tcflag_t)(ICANON | ECHO); /* ISIG stays: ^C ends the session cleanly */
    raw.c_cc[VMIN] = 0;
    raw.c_cc[VTIME] = 0;
    raw.c_cc[VSUSP] = raw.c_cc[VQUIT] = _POSIX_VDISABLE; /* they would leave it in this mode */
    s->raw = tcsetattr(STDIN_FILENO, TCSAFLUSH, &raw) == 0;
}

static void leave_raw(session *s)
{
    if (s->raw) tcsetattr(STDIN_FILENO, TCSAFLUSH, &s->saved);
    s->raw = false;
}

static void erase_view(session *s)
{
    if (s->drawn) fprintf(stderr, "\033[%dA\033[J", s->drawn);
    s->drawn = 0;
}

/* One line of the view, cut at the width of the terminal so that it stays one. */
static void draw(session *s, int width, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static void draw(session *s, int width, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    fprintf(stderr, "%.*s\n", width - 1, text);
    s->drawn++;
}

static void draw_rows(session *s, int width)
{
    const mukca_capture *c = &s->engine.capture;
    char text[512] = "";
    size_t used = 0;
    int placement = -1;
    for (int k = c->rows.n_sockets - 1; k >= 0; k--) { /* the latest fit on the line for sure */
        int n = mukca_capture_count(c, k), p = c->rows.sockets[k].placement;
        if (used + 100 > sizeof text || (!n && k != c->socket)) continue;
        if (p != placement)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s%.40s:", used ? " | " : "",
                                     c->rows.placements[p].name);
        placement = p;
        used += (size_t)snprintf(text + used, sizeof text - used, " %.16s=%d",
                                 c->rows.sockets[k].label, n);
    }
    draw(s, width, "rows         %s", text);
}

static void draw_coverage(session *s, int width)
{
    double coverage[MUKCA_MAX_JOINTS];
    char text[128] = "";
    size_t used = 0;
    mukca_capture_coverage(coverage, &s->engine.capture);
    for (int j = 0; j < s->engine.model->chain.n_joints; j++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%.0f ", 100 * coverage[j]);
    draw(s, width, "coverage     %s%% of the joints' ranges, base to tip", text);
}

static void draw_view(session *s)
{
    const recorder *r = &s->engine;
    const mukca_capture *c = &r->capture;
    struct winsize size = {.ws_col = 80};
    double rms, last, age = recorder_age(r);
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) || size.ws_col < 20) size.ws_col = 80;
    int width = size.ws_col;
    erase_view(s);
    draw(s, width, "stream       %s %.0f Hz, age %.3f s, %s: %s%s", r->channel,
         age > 1 ? 0 : r->rate, age < 1e6 ? age : 0, recorder_stream_name(r), recorder_state(r),
         c->guided ? ", guided by hand" : "");
    draw(s, width, "now          placement %s, socket %s: %d rows here, %d in all",
         mukca_capture_placement(c), mukca_capture_socket(c), mukca_capture_count(c, c->socket),
         r->session.n_rows);
    draw_rows(s, width);
    mukca_capture_spread(&rms, &last, c, c->socket);
    if (isnan(rms))
        draw(s, width, "this socket  too few rows yet to judge");
    else
        draw(s, width, "this socket  spreads by %.2f mm; the last row lies %.2f mm from the others",
             1e3 * rms, 1e3 * last);
    if (isnan(r->advice.expected))
        draw(s, width, "accuracy     nothing to expect yet");
    else
        draw(s, width, "accuracy     %.2f mm expected, %.2f mm with ten more rows here%s",
             1e3 * r->advice.expected, 1e3 * r->advice.expected_more,
             r->advice.more_rows_help ? "" : ": go on elsewhere");
    draw_coverage(s, width);
    if (s->raw)
        draw(s, width,
             "keys         a add  d delete last  s other socket  n next placement  q finish");
    fflush(stderr);
}

/* ---- hooks and keys ---- */

static void say(void *context, const char *line)
{
    session *s = context;
    if (s->call->common->quiet) return;
    erase_view(s);
    fprintf(stderr, "%s\n", line);
    s->redrawn = 0;
}

static void press(session *s, char key)
{
    char line[RECORDER_LINE] = "";
    switch (key) {
        case 'a':
            recorder_take(&s->engine, 0, NULL, NULL, line);
            break;
        case 'd':
            recorder_undo(&s->engine, line);
            break;
        case 's':
            recorder_other_socket(&s->engine, line);
            break;
        case 'n':
            recorder_next_placement(&s->engine, line);
            break;
        case 'q':
            s->finished = true;
            return;
        default:
            return;
    }
    recorder_say(&s->engine, "%s", line);
}

static void read_keys(session *s)
{
    char keys[16];
    ssize_t n = read(STDIN_FILENO, keys, sizeof keys);
    for (ssize_t i = 0; i < n; i++) press(s, keys[i]);
    if (n == 0) s->keys = false; /* hung up: would spin */
}

/* Ask on the terminal whether a mapping by order is right. */
static mukca_status confirm_map(session *s)
{
    char text[2048], answer[16] = "";
    recorder *r = &s->engine;
    recorder_describe_map(r, text, sizeof text);
    cli_say(s->call, "%s", text);
    if (!recorder_needs_confirmation(r)) return MUKCA_OK;
    if (!s->keys)
        return mukca_fail(&s->call->error, MUKCA_USAGE,
                          "%s sends no joint names; if the mapping above is right, say --map order",
                          r->channel);
    fputs("Is that right? [y/n] ", stderr);
    fflush(stderr);
    if (!fgets(answer, sizeof answer, stdin) || (answer[0] != 'y' && answer[0] != 'Y'))
        return mukca_fail(&s->call->error, MUKCA_USAGE,
                          "not confirmed: give the readings' numbers, as in --map 8-14");
    r->confirmed = true;
    return MUKCA_OK;
}

/* ---- the session ---- */

static mukca_status loop(session *s)
{
    recorder *r = &s->engine;
    mukca_status status = MUKCA_OK;
    while (!s->finished) {
        bool readable;
        status = recorder_step(r, s->view ? 50 : 200, s->keys ? STDIN_FILENO : -1, &readable);
        if (status) break;
        if (readable) read_keys(s);
        if (cli_interrupted())
            return mukca_fail(&s->call->error, MUKCA_INTERRUPTED,
                              "interrupted; %d rows are safe in %s (--resume goes on)",
                              r->session.n_rows, r->session.path);
        double now = cli_elapsed(s->call);
        if (now - s->published >= publish_period) {
            recorder_publish_status(r, NULL);
            s->published = now;
        }
        if (s->view && now - s->redrawn >= redraw_period) {
            draw_view(s);
            s->redrawn = now;
        }
        if (s->options->rows && r->session.n_rows >= s->options->rows) s->finished = true;
    }
    return status == MUKCA_NEGATIVE ? MUKCA_OK : status; /* the log's end */
}

static json_t *summary(const session *s)
{
    const recorder *r = &s->engine;
    const mukca_dataset *rows = &r->capture.rows;
    json_t *sockets = json_array();
    for (int k = 0; k < rows->n_sockets; k++) {
        double rms;
        int n = mukca_capture_count(&r->capture, k);
        mukca_capture_spread(&rms, NULL, &r->capture, k);
        if (n)
            json_array_append_new(
                sockets,
                json_pack("{s:s, s:s, s:i, s:o}", "placement",
                          rows->placements[rows->sockets[k].placement].name, "socket",
                          rows->sockets[k].label, "rows", n, "spread_m", cli_json_real(rms)));
    }
    return json_pack("{s:s, s:s, s:i, s:s, s:s, s:s, s:I, s:I, s:o, s:o, s:o, s:b}", "schema",
                     "mukca.capture/1", "session", r->session.path, "rows", r->session.n_rows,
                     "channel", r->channel, "type", r->types.type[r->type].name, "stream",
                     recorder_stream_name(r), "received", (json_int_t)r->received, "refused",
                     (json_int_t)r->refused, "longest_gap_s", cli_json_real(r->longest_gap),
                     "sockets", sockets, "expected_m", cli_json_real(r->advice.expected),
                     "more_rows_help", (int)r->advice.more_rows_help);
}

static void conclude(session *s)
{
    const recorder *r = &s->engine;
    cli_tell(s->call,
             "%d rows in %s; %lld joint states received, %lld refused, longest gap %.3f s.",
             r->session.n_rows, r->session.path, (long long)r->received, (long long)r->refused,
             r->longest_gap);
    if (mukca_lcm_link_skipped(r->link))
        cli_say(s->call, "the log is damaged: %lld bytes of it were skipped\n",
                (long long)mukca_lcm_link_skipped(r->link));
    if (r->session.n_rows)
        cli_say(s->call, "Next:\n  mukca calibrate --urdf %s %s -o offsets.tsv\n",
                s->call->common->urdf, r->session.path);
}

static mukca_status check_usage(const session *s)
{
    const capture_options *o = s->options;
    const cli_common *c = s->call->common;
    mukca_error *error = &s->call->error;
    if (!c->output || strcmp(c->output, "-") == 0)
        return mukca_fail(error, MUKCA_USAGE, "-o FILE is needed: where the session goes");
    if (!s->keys && !o->trigger && !o->recorder.still)
        return mukca_fail(error, MUKCA_USAGE,
                          "without a terminal there are no keys: say --trigger (LCM messages) or "
                          "--still");
    if (o->rows < 0) return mukca_fail(error, MUKCA_USAGE, "--rows must be above 0");
    if (!o->resume && !c->force && access(c->output, F_OK) == 0)
        return mukca_fail(error, MUKCA_INPUT,
                          "%s exists: --resume goes on with it, --force overwrites it", c->output);
    const char *url = o->recorder.lcm_url;
    const char *files[] = {c->output, c->json, o->recorder.record,
                           url && strncmp(url, "file://", 7) == 0 ? url + 7 : NULL};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < i; k++)
            if (mukca_output_same(files[i], files[k]))
                return mukca_fail(error, MUKCA_USAGE,
                                  "session, --json and logs cannot be the same file: %.100s",
                                  files[i]);
    if (c->json) return mukca_output_check(c->json, c->force, error);
    return MUKCA_OK;
}

static mukca_status run(cli_call *call)
{
    const capture_options *o = call->options;
    session *s = calloc(1, sizeof *s);
    cli_model *model = calloc(1, sizeof *model);
    mukca_status status = MUKCA_OK;
    if (!s || !model) {
        status = mukca_fail(&call->error, MUKCA_MEMORY, "out of memory");
        goto out;
    }
    const char *term = getenv("TERM");
    s->call = call;
    s->options = o;
    s->keys = isatty(STDIN_FILENO);
    s->view = isatty(STDERR_FILENO) && !call->common->quiet && term && strcmp(term, "dumb") != 0;
    recorder_hooks hooks = {.say = say, .context = s};
    status = check_usage(s);
    if (!status) status = cli_load_model(call, model);
    if (!status) status = recorder_open(&s->engine, call, &o->recorder, model, o->trigger, &hooks);
    if (!status) status = recorder_connect(&s->engine, o->wait);
    if (!status) status = confirm_map(s);
    if (!status)
        status = recorder_begin(&s->engine, call->common->output, o->resume, call->common->force);
    if (!status) status = recorder_keep_log(&s->engine);
    if (status) goto out;
    enter_raw(s);
    status = loop(s);
    if (s->view) draw_view(s);
    leave_raw(s);
    if (status == MUKCA_OK || status == MUKCA_INTERRUPTED) {
        recorder_publish_status(&s->engine, "stopped");
        conclude(s);
        mukca_status written = cli_write_json(call, call->common->json ? summary(s) : NULL);
        if (written) status = written;
    }
    if (!status && !s->engine.session.n_rows)
        status = mukca_fail(&call->error, MUKCA_NEGATIVE, "no row was recorded");
out:
    if (s) {
        leave_raw(s);
        recorder_close(&s->engine);
    }
    free(model);
    free(s);
    return status;
}

#define AT(kind, name, argument, member, help)                                 \
    {                                                                          \
        name, 0, kind, argument, help, NULL, offsetof(capture_options, member) \
    }

static const cli_option options[] = {
    CLI_MODEL_OPTIONS,
    CLI_OFFSETS_OPTION,
    CLI_OUTPUT_OPTION("the session (TSV, or CSV by its ending)"),
    RECORDER_OPTIONS(capture_options),
    AT(CLI_FLAG, "trigger", NULL, trigger, "take a sample on each message on MUKCA_TRIGGER"),
    AT(CLI_FLAG, "resume", NULL, resume, "go on with an existing session"),
    AT(CLI_INTEGER, "rows", "N", rows, "finish when the session has N rows"),
    AT(CLI_POSITIVE, "wait", "S", wait,
       "give up without joint states after S seconds (default: 10)"),
    CLI_COMMON(distance, 0, CLI_POSITIVE, "M", "distance between the sockets, m (default: 0.05)"),
    CLI_JSON_OPTION,
    CLI_FORCE_OPTION,
    CLI_TALK_OPTIONS,
    CLI_END_OPTIONS,
};

static const capture_options defaults = {.wait = 10};

const cli_command cli_command_capture = {
    .name = "capture",
    .group = CLI_MEASURE,
    .summary = "record a session from the joint states of the robot (LCM)",
    .synopsis = "",
    .description =
        "Listens to the robot's joint states, and records one row each time that you press a, that "
        "a message comes on MUKCA_TRIGGER (--trigger), or that the arm stands still with its ball "
        "in a socket (--still). A row is the mean over a still window; while the arm moves it is "
        "refused. Each row is on disk before it is acknowledged.\n\n"
        "Put the ball into socket 0 of the first placement, take some 20 rows in postures as "
        "different as you can, press s and do the same in the other socket, then move the tool, "
        "press n, and so on; three or four placements all around the base are good. The screen "
        "shows how far the predictions at this socket spread, which a badly seated ball makes "
        "jump, and when more rows there help no more.\n\n"
        "Keys: a add, d delete the last row, s other socket, n next placement, q finish.\n\n"
        "Known types of joint states, and where they are usually sent:\n"
#define STATE_HELP(file, type, channel, fingerprint) "  " type ", " channel "\n"
    MUKCA_LCM_STATE_LIST(STATE_HELP)
#undef STATE_HELP
        "\nAny other type works with a description: --type and --position.",
    .example =
        "mukca capture --urdf data/demo/arm.urdf --lcm-url file://data/demo/guided.lcmlog "
        "--trigger -o build/guided.tsv --force",
    .options = options,
    .options_size = sizeof(capture_options),
    .defaults = &defaults,
    .run = run,
};
