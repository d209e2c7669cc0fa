/* `mukca send`: one command to `mukca serve`, and its answer. */
#include <string.h>
#include <time.h>

#include "base/suggest.h"
#include "cli/live.h"
#include "lcm/message.h"
#include "record/server.h"

typedef struct {
    cli_common common;
    mukca_lcm_network network;
    const char *prefix, *key;
    double timeout;
} send_options;

typedef struct {
    cli_call *call;
    mukca_lcm_link link;
    mukca_lcm_key key;
    int64_t id;
    bool wants_status;
    bool answered;
    mukca_status status;
    mukca_message_result result;
} send_work;

/* The offsets table as text, without comments. */
static void print_table(const mukca_message_result *m)
{
    if (!m->n) return;
    puts("joint\tparameter\tunit\tnominal\tcalibrated\toffset\tsigma\tidentifiable");
    for (int i = 0; i < m->n; i++)
        printf("%s\t%s\t%s\t%.17g\t%.17g\t%.17g\t%.17g\t%d\n", m->joint[i], m->parameter[i],
               m->unit[i], m->nominal[i], m->calibrated[i], m->offset[i], m->sigma[i],
               m->identifiable[i]);
}

/* Print the reply: its line, then the table.  With --json - standard output is JSON, and the table
 * is omitted. */
static void take_result(send_work *c, const mukca_message_result *m)
{
    if (m->id != c->id) return;
    c->answered = true;
    c->status = (mukca_status)m->code;
    if (c->status != MUKCA_OK && c->status != MUKCA_NEGATIVE)
        cli_fail(c->call, c->status, "%.250s", m->text);
    else if (m->n)
        cli_log(c->call, "%s\n", m->text);
    else
        cli_answer(c->call, "%s\n", m->text);
    const char *json = c->call->common->json;
    mukca_status written = MUKCA_OK;
    if (!json || strcmp(json, "-") != 0) print_table(m);
    if (json && m->json[0]) {
        mukca_output output;
        written = mukca_output_open(&output, json, c->call->common->force, &c->call->error);
        if (written == MUKCA_OK) fputs(m->json, output.stream);
        written = mukca_output_finish(&output, written, &c->call->error);
    } else if (json) {
        written = cli_write_json(c->call, cli_json(FIELD(m, verb), FIELD(m, code), FIELD(m, text)));
    }
    if (written) c->status = written;
}

/* Write a status message as JSON, by default to standard output. */
static void take_status(send_work *c, const mukca_message_status *m)
{
    cli_common *common = c->call->common;
    if (!common->json) common->json = "-";
    c->answered = true;
    c->status = cli_write_json(
        c->call, cli_json(FIELD(m, state), FIELD(m, session), FIELD(m, placement), FIELD(m, socket),
                          FIELD(m, rows), FIELD(m, rows_here), FIELD(m, channel), FIELD(m, type),
                          FIELD(m, stream), FIELD(m, rate_hz), FIELD(m, age_s), FIELD(m, received),
                          FIELD(m, refused), FIELD(m, spread_m), FIELD(m, expected_m),
                          FIELD(m, more_rows_help), KEY("said", m->text)));
}

static void on_packet(void *context, const mukca_lcm_packet *packet)
{
    send_work *c = context;
    mukca_message_status status;
    if (c->answered) return;
    if (c->wants_status) {
        if (!mukca_message_decode(&status, MUKCA_MESSAGE_STATUS, packet->data, packet->size, NULL))
            take_status(c, &status);
    } else if (!mukca_message_decode(&c->result, MUKCA_MESSAGE_RESULT, packet->data, packet->size,
                                     NULL)) {
        take_result(c, &c->result);
    }
}

static mukca_status send_command(send_work *c)
{
    const cli_list *words = &c->call->arguments;
    const send_options *o = c->call->options;
    char channel[64];
    unsigned char buffer[4096 + MUKCA_LCM_SIGNATURE];
    mukca_message_command command = {
        .utime = mukca_lcm_link_clock(&c->link), .id = c->id, .verb = words->items[0]};
    if (words->n - 1 > MUKCA_MESSAGE_ARGUMENTS)
        return cli_fail(c->call, MUKCA_USAGE, "at most %d arguments", MUKCA_MESSAGE_ARGUMENTS);
    for (int i = 1; i < words->n; i++) command.argument[command.n++] = words->items[i];
    size_t size = mukca_message_encode(buffer, 4096, MUKCA_MESSAGE_COMMAND, &command);
    if (!size || size > 4096) return cli_fail(c->call, MUKCA_USAGE, "the arguments are too long");
    mukca_message_channel(channel, MUKCA_MESSAGE_COMMAND, o->prefix);
    if (o->key) {
        const mukca_lcm_packet packet = {.channel = channel, .data = buffer, .size = size};
        mukca_lcm_signature_make(buffer + size, &c->key, &packet);
        size += MUKCA_LCM_SIGNATURE;
    }
    return mukca_lcm_link_publish(&c->link, channel, buffer, size, &c->call->error);
}

static mukca_status check_verb(cli_call *call, const char *verb)
{
    const char *meant = NULL;
    char text[MUKCA_SUGGEST_TEXT];
    int best = 99;
    for (const char *const *v = mukca_server_verbs; *v; v++) {
        if (strcmp(verb, *v) == 0) return MUKCA_OK;
        if (mukca_suggest_better(&best, verb, *v)) meant = *v;
    }
    return cli_fail(call, MUKCA_USAGE, "serve has no command '%.40s'; %s", verb,
                    mukca_suggest_text(text, meant, "`mukca help serve` lists them"));
}

static mukca_status run(cli_call *call)
{
    const send_options *o = call->options;
    mukca_error *error = &call->error;
    send_work *c = call->work;
    mukca_lcm_channels channels = {.all = false};
    char *channel = channels.name[0];
    struct timespec t;
    c->call = call;
    clock_gettime(CLOCK_REALTIME, &t);
    c->id = (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
    c->wants_status = strcmp(call->arguments.items[0], "status") == 0;
    MUKCA_TRY(check_verb(call, call->arguments.items[0]));
    MUKCA_TRY(o->key ? mukca_lcm_key_read(&c->key, o->key, error) : MUKCA_OK);
    MUKCA_TRY(mukca_lcm_link_open(&c->link, &o->network, on_packet, c, error));
    if (c->link.replays)
        return mukca_fail(error, MUKCA_USAGE, "commands need a network, not a log");
    mukca_message_channel(channel, c->wants_status ? MUKCA_MESSAGE_STATUS : MUKCA_MESSAGE_RESULT,
                          o->prefix);
    mukca_lcm_multicast_listen(c->link.multicast, &channels);
    MUKCA_TRY(c->wants_status ? MUKCA_OK : send_command(c));
    const double deadline = cli_elapsed(call) + o->timeout;
    while (!c->answered) {
        const mukca_status status = mukca_lcm_link_wait(&c->link, 100, -1, NULL, error);
        if (cli_interrupted())
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted; serve completes the command");
        if (status != MUKCA_OK) return status;
        if (!c->answered && cli_elapsed(call) > deadline)
            return mukca_fail(error, MUKCA_TRANSPORT,
                              "no answer on %s for %g s: is mukca serve running on this network "
                              "(--lcm-url, --prefix)?",
                              channel, o->timeout);
    }
    return c->status;
}

static void release(void *work)
{
    send_work *c = work;
    mukca_lcm_link_close(&c->link);
}

static const cli_option options[] = {
    CLI_OPTION(send_options, network.url, "lcm-url", CLI_TEXT, "URL",
               "LCM network (default: LCM_DEFAULT_URL, else LCM's own)"),
    CLI_NETWORK_OPTIONS(send_options, network),
    CLI_OPTION(send_options, key, "key", CLI_INPUT, "FILE",
               "sign the command with the key in this file, as serve --key requires"),
    CLI_OPTION(send_options, prefix, "prefix", CLI_TEXT, "NAME",
               "prefix of the channels of serve (default: MUKCA)"),
    CLI_OPTION(send_options, timeout, "timeout", CLI_POSITIVE, "S",
               "longest wait for the answer, s (default: 60)"),
    {.name = NULL}};

static const send_options defaults = {.timeout = 60};

const cli_command cli_command_send = {
    .name = "send",
    .group = CLI_MEASURE,
    .summary = "send a command to `mukca serve` and print its answer",
    .synopsis = "COMMAND [ARGUMENT...]",
    .description =
        "COMMAND is one of those that `mukca help serve` lists, or status, which prints the next "
        "status message as JSON. The answer goes to standard output; where it is an offsets table "
        "(calibrate, diagnose, result), its summary goes to standard error. The exit code is that "
        "of the command; 4: no answer.",
    .example = "  mukca send status",
    .with = CLI_WITH_JSON,
    .options = options,
    .options_size = sizeof(send_options),
    .defaults = &defaults,
    .run = run,
    .work_size = sizeof(send_work),
    .release = release,
};
