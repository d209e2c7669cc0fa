/* The recorder and its link: detection of channel, type, mapping and silence. */
#include "record/recorder.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/text.h"
#include "lcm/type.h"

static const double listen_s = 1, /* our choice: silence before listening to all channels */
    silence_s = 1.8;              /* and before it is reported, within 2 s */

enum {                      /* us, our choice */
       SEARCH_US = 500000,  /* wait for other matching streams after the first */
       PROBLEM_US = 1000000 /* wait for a valid message after an invalid one */
};

/* Receive all channels, or only those in use. */
static void listen_to(mukca_recorder *r, bool all)
{
    mukca_lcm_channels channels = {.all = all};
    if (!r->stream.lines) memcpy(channels.name[0], r->stream.channel, sizeof channels.name[0]);
    if (r->options->triggers)
        memcpy(channels.name[1], r->requests.trigger_channel, sizeof channels.name[1]);
    if (r->hooks.command)
        memcpy(channels.name[2], r->requests.command_channel, sizeof channels.name[2]);
    r->stream.search.listens_to_all = all;
    mukca_lcm_multicast_listen(r->link.multicast, &channels);
}

/* Select the channel whose messages fit the arm; false: more than one do. */
static bool choose_channel(mukca_stream *stream, int n_joints)
{
    const mukca_stream_heard *fits = NULL;
    for (int i = 0; i < stream->search.n_heard; i++) {
        const mukca_stream_heard *h = &stream->search.heard[i];
        if (h->joints < n_joints) continue;
        if (fits)
            mukca_fail(&stream->problem, MUKCA_INPUT,
                       "%s and %s both send joint states: choose with --channel", fits->channel,
                       h->channel);
        if (fits) return false;
        fits = h;
    }
    if (fits) memcpy(stream->channel, fits->channel, sizeof stream->channel);
    return true;
}

/* ---- requests over LCM; messages of a log have no sender and are not limited ---- */

/* Our choice: above the rate of people and of programs that wait for replies, below that of a
 * disk. */
static const double requests_per_s = 50, first_requests = 40, most_requests = 100;

/* Tolerated clock difference between signer and receiver, s: clocks set by hand agree within
 * seconds.  A recorded request cannot be replayed, which permits a wide tolerance. */
static const double clock_tolerance = 10;

bool mukca_budget_take(mukca_budget *b, int64_t now, double rate, double first, double most)
{
    const double elapsed = 1e-6 * (double)(now - b->time);
    b->left = b->time ? fmin(b->left + rate * fmax(elapsed, 0), most) : first;
    b->time = now;
    if (b->left < 1) return false;
    b->left -= 1;
    return true;
}

/* Whether a sender's request is within its rate limit.  False: it is refused. */
static bool may_request(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    if (!packet->sender) return true;
    mukca_requests_sender *s = &r->requests.sender[0]; /* its entry, else the oldest */
    for (int i = 0; i < MUKCA_REQUESTS_SENDERS && s->id != packet->sender; i++) {
        mukca_requests_sender *other = &r->requests.sender[i];
        if (other->id == packet->sender || other->budget.time < s->budget.time) s = other;
    }
    if (s->id != packet->sender) *s = (mukca_requests_sender){.id = packet->sender};
    if (mukca_budget_take(&s->budget, packet->time, requests_per_s, first_requests, most_requests))
        return true;
    mukca_recorder_refuse(r, MUKCA_RECORDER_RATE,
                          "%s: more than %g requests a second of one sender: ignored",
                          packet->channel, requests_per_s);
    return false;
}

bool mukca_requests_decode(void *message, mukca_recorder *r, mukca_message_kind kind,
                           const mukca_lcm_packet *packet)
{
    mukca_error error;
    if (!mukca_message_decode(message, kind, packet->data, packet->size, &error))
        return may_request(r, packet);
    mukca_recorder_refuse(r, MUKCA_RECORDER_OWN_MESSAGE, "%s: %s: ignored", packet->channel,
                          error.text);
    return false;
}

mukca_status mukca_requests_check_signature(mukca_recorder *r, const mukca_lcm_packet *packet,
                                            int64_t utime, mukca_error *error)
{
    if (!r->options->key) return MUKCA_OK;
    if (!mukca_lcm_signature_check(&r->requests.key, packet))
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "not signed with the key that is required here: send it with --key FILE");
    const double ahead = 1e-6 * ((double)utime - (double)packet->time); /* utime: any number */
    if (fabs(ahead) > clock_tolerance)
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "signed %.0f s %s: synchronise the clocks of both machines", fabs(ahead),
                          ahead > 0 ? "in the future" : "ago");
    if (utime <= r->requests.last_signed)
        return mukca_fail(error, MUKCA_NEGATIVE,
                          "not newer than the last signed request, or sent twice: send another");
    r->requests.last_signed = utime;
    return MUKCA_OK;
}

static void take_trigger(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    mukca_message_trigger trigger;
    mukca_error error;
    if (!mukca_requests_decode(&trigger, r, MUKCA_MESSAGE_TRIGGER, packet)) return;
    mukca_status status = mukca_requests_check_signature(r, packet, trigger.utime, &error);
    if (status == MUKCA_OK && r->hooks.trigger)
        status = r->hooks.trigger(r->hooks.context, packet, &error);
    if (status != MUKCA_OK) {
        const mukca_message_sample answer = {.id = trigger.id, .text = error.text};
        mukca_recorder_warn(r, MUKCA_RECORDER_OWN_MESSAGE, "%s: %s", packet->channel, error.text);
        r->session.refused++; /* a sample, not a message */
        mukca_recorder_publish(r, MUKCA_MESSAGE_SAMPLE, &answer);
        return;
    }
    mukca_sampling_trigger(r, &trigger, packet->time);
}

/* ---- the link ---- */

static void hear(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    const mukca_lcm_types *types = &r->stream.types;
    mukca_stream_search *search = &r->stream.search;
    if (mukca_message_identify(packet->data, packet->size)) return;
    for (int i = 0; i < search->n_heard; i++)
        if (strcmp(search->heard[i].channel, packet->channel) == 0) return;
    if (search->n_heard == MUKCA_STREAM_HEARD) return;
    mukca_stream_heard *h = &search->heard[search->n_heard++];
    mukca_lcm_joints joints;
    mukca_error none; /* a malformed message counts as one without joints */
    snprintf(h->channel, sizeof h->channel, "%s", packet->channel);
    h->type = mukca_lcm_types_find(types, packet->data, packet->size);
    h->joints = 0;
    if (mukca_lcm_type_has_joints(types, h->type) &&
        mukca_lcm_decode_joints(&joints, types, h->type, packet->data, packet->size, &none) ==
            MUKCA_OK)
        h->joints = joints.n;
    if (h->joints >= r->chain->n_joints && !search->fit_heard) search->fit_heard = packet->time;
}

static void receive(void *context, const mukca_lcm_packet *packet)
{
    mukca_recorder *r = context;
    bool ahead = r->link.replays && !r->stream.connected; /* it will be replayed */
    r->packet_time = packet->time;
    if (strcmp(packet->channel, r->stream.channel) == 0)
        mukca_stream_take(r, packet);
    else if (r->options->triggers && strcmp(packet->channel, r->requests.trigger_channel) == 0 &&
             !ahead)
        take_trigger(r, packet);
    else if (r->hooks.command && strcmp(packet->channel, r->requests.command_channel) == 0 &&
             !ahead)
        r->hooks.command(r->hooks.context, packet);
    else
        hear(r, packet);
    r->packet_time = 0;
}

static mukca_status open_link(mukca_recorder *r, mukca_error *error)
{
    mukca_stream *stream = &r->stream;
    mukca_lcm_link_close(&r->link);
    stream->count = (mukca_stream_count){.received = 0};
    stream->sender = (mukca_stream_sender){.id = 0};
    stream->silence = (mukca_stream_silence){.begun = false};
    stream->search = (mukca_stream_search){.n_heard = 0};
    stream->last.arrival = 0;
    memset(&r->reports, 0, offsetof(mukca_recorder_reports, last_line));
    mukca_lcm_network network = r->options->network;
    network.none = stream->lines && !r->options->triggers;
    MUKCA_TRY(mukca_lcm_link_open(&r->link, &network, receive, r, error));
    stream->search.opened = mukca_lcm_link_clock(&r->link);
    listen_to(r, !stream->map.made && !stream->lines);
    return MUKCA_OK;
}

static mukca_status read_types(mukca_recorder *r, mukca_error *error)
{
    const mukca_recorder_types *o = &r->options->types;
    mukca_lcm_types *types = &r->stream.types;
    MUKCA_TRY(mukca_lcm_types_init(types, error));
    if (o->n && !o->position)
        return mukca_fail(
            error, MUKCA_USAGE,
            "--type needs --position FIELD: which field contains the joint positions?");
    if (!o->n && (o->position || o->names))
        return mukca_fail(error, MUKCA_USAGE, "--position and --names belong to a --type FILE.lcm");
    if (!o->n) return MUKCA_OK;
    for (int i = 0; i < o->n; i++) MUKCA_TRY(mukca_lcm_types_read(types, o->file[i], error));
    /* from the last struct backwards, as nested types come first */
    int t = types->n_types;
    mukca_status status;
    do status = mukca_lcm_type_set_role(types, --t, MUKCA_LCM_ROLE_POSITION, o->position, error);
    while (status != MUKCA_OK && t > MUKCA_LCM_STATES);
    if (status != MUKCA_OK) return status;
    mukca_error none; /* time stamps are optional */
    if (mukca_lcm_type_set_role(types, t, MUKCA_LCM_ROLE_TIME, "utime", &none))
        (void)mukca_lcm_type_set_role(types, t, MUKCA_LCM_ROLE_TIME, "timestamp", &none);
    if (!o->names) return MUKCA_OK;
    return mukca_lcm_type_set_role(types, t, MUKCA_LCM_ROLE_NAME, o->names, error);
}

static mukca_status open_lines(mukca_recorder *r, mukca_error *error)
{
    const mukca_recorder_options *o = r->options;
    if (o->channel || o->types.n)
        return mukca_fail(error, MUKCA_USAGE,
                          "--stdin reads lines: --channel and --type belong to LCM");
    r->stream.lines = malloc(sizeof *r->stream.lines);
    if (!r->stream.lines) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_joint_lines_open(r->stream.lines, STDIN_FILENO);
    snprintf(r->stream.channel, sizeof r->stream.channel, "standard input");
    return MUKCA_OK;
}

mukca_status mukca_recorder_open(mukca_recorder *r, const mukca_recorder_options *options,
                                 const mukca_chain *chain, const double *theta,
                                 const mukca_recorder_hooks *hooks, mukca_error *error)
{
    memset(r, 0, sizeof *r);
    r->options = options;
    r->chain = chain;
    r->hooks = *hooks;
    r->stream.type = -1;
    MUKCA_TRY(read_types(r, error));
    MUKCA_TRY(mukca_sampling_prepare(r, theta, error));
    MUKCA_TRY(mukca_stream_check_map(r, error));
    if (options->channel && strlen(options->channel) >= sizeof r->stream.channel)
        return mukca_fail(error, MUKCA_USAGE, "--channel: at most 63 characters");
    if (options->channel) memcpy(r->stream.channel, options->channel, strlen(options->channel) + 1);
    mukca_message_channel(r->requests.trigger_channel, MUKCA_MESSAGE_TRIGGER, options->prefix);
    mukca_message_channel(r->requests.command_channel, MUKCA_MESSAGE_COMMAND, options->prefix);
    mukca_status status = options->lines ? open_lines(r, error) : MUKCA_OK;
    if (status == MUKCA_OK && options->key)
        status = mukca_lcm_key_read(&r->requests.key, options->key, error);
    if (status == MUKCA_OK) status = open_link(r, error);
    /* requests signed before the start may have been accepted by an earlier process */
    if (status == MUKCA_OK && !r->link.replays) r->requests.last_signed = r->stream.search.opened;
    return status;
}

void mukca_recorder_close(mukca_recorder *r)
{
    mukca_session_close(&r->session.file);
    mukca_capture_free(&r->session.capture);
    mukca_lcm_link_close(&r->link);
    free(r->stream.lines);
    r->stream.lines = NULL;
}

mukca_status mukca_recorder_connect(mukca_recorder *r, double wait, mukca_error *error)
{
    mukca_stream *stream = &r->stream;
    mukca_status status = MUKCA_OK;
    int64_t found = 0; /* us, time of the first problem */
    while (!status && !stream->map.made) {
        status = mukca_recorder_step(r, 100, -1, NULL, error);
        int64_t now = mukca_lcm_link_clock(&r->link);
        if (stream->problem.status && !found) found = now;
        if (stream->problem.status && now - found > PROBLEM_US) break;
        if (r->hooks.interrupted && r->hooks.interrupted())
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        if (!r->link.replays && wait >= 0 && 1e-6 * (double)(now - stream->search.opened) > wait)
            status = MUKCA_NEGATIVE;
    }
    if (status != MUKCA_OK && status != MUKCA_NEGATIVE) return status;
    if (stream->problem.status && !stream->map.made) {
        *error = stream->problem;
        return stream->problem.status;
    }
    if (status == MUKCA_NEGATIVE && !stream->map.made) { /* a short log may end at once */
        char line[MUKCA_RECORDER_LINE];
        mukca_text text = MUKCA_TEXT(line);
        mukca_recorder_describe_silence(&text, r, "");
        return mukca_fail(error, MUKCA_TRANSPORT, "%s", line);
    }
    stream->connected = true;
    /* messages read ahead from a log are recorded, too */
    return r->link.replays ? open_link(r, error) : MUKCA_OK;
}

/* Detect silence on a network.  It is the time of waiting: a process that was stopped, or is late,
 * has not heard whether the stream goes on. */
static void watch(mukca_recorder *r)
{
    mukca_stream_silence *silence = &r->stream.silence;
    mukca_stream_search *search = &r->stream.search;
    if (r->stream.map.made && search->listens_to_all && silence->duration < listen_s) {
        listen_to(r, false);
    } else if (!r->stream.lines && !search->listens_to_all && silence->duration >= listen_s) {
        search->n_heard = 0;
        listen_to(r, true);
    }
    if (silence->duration < silence_s) return;
    silence->begun = true;
    if (silence->reported || mukca_recorder_reported(r, MUKCA_RECORDER_SILENT)) return;
    char line[MUKCA_RECORDER_LINE], since[40];
    mukca_text text = MUKCA_TEXT(line);
    silence->reported = true;
    snprintf(since, sizeof since, " for %.1f s", silence->duration);
    mukca_recorder_describe_silence(&text, r, since);
    mukca_recorder_warn(r, MUKCA_RECORDER_SILENT, "%s", line);
}

static void warn_dropped(mukca_recorder *r)
{
    char reason[128];
    int64_t dropped = mukca_lcm_multicast_dropped(r->link.multicast, reason);
    if (dropped == r->stream.count.dropped) return;
    r->stream.count.dropped = dropped;
    mukca_recorder_warn(r, MUKCA_RECORDER_DROPPED, "network: messages dropped: %s", reason);
}

mukca_status mukca_recorder_step(mukca_recorder *r, int timeout_ms, int other, bool *readable,
                                 mukca_error *error)
{
    mukca_stream *stream = &r->stream;
    const int64_t received = stream->count.received;
    const double begun = mukca_clock_seconds();
    mukca_status status = stream->lines
                              ? mukca_stream_wait_lines(r, timeout_ms, other, readable, error)
                              : mukca_lcm_link_wait(&r->link, timeout_ms, other, readable, error);
    int64_t now = mukca_lcm_link_clock(&r->link);
    bool replays = r->link.replays, ended = status == MUKCA_NEGATIVE;
    if (!stream->channel[0] && stream->search.fit_heard &&
        (ended || now - stream->search.fit_heard > SEARCH_US)) {
        if (!choose_channel(stream, r->chain->n_joints)) return status;
        if (replays) return open_link(r, error); /* restart with the known channel */
    }
    if (replays || status) return status;
    warn_dropped(r);
    if (stream->map.made && stream->map.confirmed) stream->connected = true;
    stream->silence.duration += fmin(mukca_clock_seconds() - begun, 1e-3 * timeout_ms + 0.1);
    if (stream->count.received != received) stream->silence.duration = 0;
    watch(r);
    return MUKCA_OK;
}

mukca_status mukca_recorder_finish(const mukca_recorder *r, mukca_error *error)
{
    if (!r->session.unwritten) return MUKCA_OK;
    return mukca_fail(error, MUKCA_MEMORY, "not all was written (%d failures); the first: %s",
                      r->session.unwritten, r->session.first_unwritten.text);
}
