/* The recorder's reports to the user and its LCM messages. */
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "record/messages.h"

static const int64_t repeat_us = 10000000; /* of reports of the same trouble */

const char *const mukca_recorder_streams[] = {"raw", "corrected", NULL};

const char *mukca_recorder_stream(const mukca_recorder *r)
{
    return mukca_recorder_streams[r->options->stream];
}

const char *mukca_stream_type(const mukca_recorder *r)
{
    const mukca_stream *stream = &r->stream;
    if (stream->lines) return stream->lines->format;
    return stream->type < 0 ? "" : stream->types.type[stream->type].name;
}

double mukca_stream_age(const mukca_recorder *r)
{
    const mukca_stream *stream = &r->stream;
    if (!stream->last.arrival) return HUGE_VAL;
    double age = 1e-6 * (double)(mukca_lcm_link_clock(&r->link) - stream->last.arrival);
    return age > 0 ? age : 0;
}

void mukca_recorder_note(void *context, const char *text)
{
    mukca_recorder *r = context;
    snprintf(r->reports.last_line, sizeof r->reports.last_line, "%s", text);
    mukca_utf8_mend(r->reports.last_line); /* of the network's texts */
    if (r->hooks.report.write) r->hooks.report.write(r->hooks.report.context, r->reports.last_line);
}

bool mukca_recorder_reported(const mukca_recorder *r, mukca_recorder_trouble kind)
{
    const int64_t ago = mukca_lcm_link_clock(&r->link) - r->reports.reported[kind];
    return r->reports.reported[kind] && ago >= 0 && ago < repeat_us;
}

void mukca_recorder_warn(mukca_recorder *r, mukca_recorder_trouble kind, const char *format, ...)
{
    char text[MUKCA_RECORDER_LINE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    r->reports.occurrences[kind]++;
    if (mukca_recorder_reported(r, kind)) return;
    const int64_t now = mukca_lcm_link_clock(&r->link);
    r->reports.reported[kind] = now ? now : 1;
    if (r->reports.occurrences[kind] > 1)
        mukca_recorder_report(r, "%s (%" PRId64 " times so far)", text,
                              r->reports.occurrences[kind]);
    else
        mukca_recorder_report(r, "%s", text);
}

void mukca_recorder_describe_silence(mukca_text *text, const mukca_recorder *r, const char *since)
{
    const mukca_stream *stream = &r->stream;
    if (stream->lines) {
        mukca_text_put(text, "no joint state on standard input%s: does the program before it run?",
                       since);
        return;
    }
    mukca_text_put(text, "no joint state%s%s%s; heard instead: ", stream->channel[0] ? " on " : "",
                   stream->channel, since);
    bool unknown = false;
    for (int i = 0; i < stream->search.n_heard; i++) {
        const mukca_stream_heard *h = &stream->search.heard[i];
        unknown |= h->type < 0;
        mukca_text_put(text, "%s%s (%s", i ? ", " : "", h->channel,
                       h->type < 0 ? "unknown type" : stream->types.type[h->type].name);
        if (h->joints) mukca_text_put(text, ", %d joints", h->joints);
        mukca_text_put(text, ")");
    }
    if (unknown)
        mukca_text_put(text, "; describe an unknown type with --type FILE.lcm --position FIELD");
    if (!stream->search.n_heard)
        mukca_text_put(text, "nothing (is the sender on this network, and the multicast route?)");
}

bool mukca_recorder_publish(mukca_recorder *r, mukca_message_kind kind, const void *message)
{
    char channel[64];
    void *large = NULL;
    mukca_error error;
    size_t size = mukca_message_encode(r->outgoing, sizeof r->outgoing, kind, message);
    if (size > sizeof r->outgoing) { /* a result with its JSON; others fit */
        large = malloc(size);
        if (!large) return false;
        mukca_message_encode(large, size, kind, message);
    }
    mukca_message_channel(channel, kind, r->options->prefix);
    bool sent = size && mukca_lcm_link_publish(&r->link, channel, large ? large : r->outgoing, size,
                                               &error) == MUKCA_OK;
    if (size && !sent) mukca_recorder_warn(r, MUKCA_RECORDER_OWN_MESSAGE, "%s", error.text);
    free(large);
    return sent;
}

/* ---- status ---- */

const char *mukca_sampling_state(const mukca_recorder *r)
{
    mukca_capture_sample sample;
    mukca_error none;
    const double age = mukca_stream_age(r);
    if (!r->stream.map.made || age > 1) return "no_stream";
    return mukca_capture_take(&sample, &r->session.capture, age, &none) ? "moving" : "still";
}

void mukca_sampling_publish_status(mukca_recorder *r, const char *state)
{
    mukca_sampling *s = &r->session;
    const mukca_stream *stream = &r->stream;
    const mukca_capture *c = &s->capture;
    const char *now = mukca_sampling_state(r);
    const double age = mukca_stream_age(r);
    mukca_message_status m = {
        .utime = mukca_lcm_link_clock(&r->link),
        .state = state ? state : now,
        .text = r->reports.last_line,
        .session = s->file.open ? s->file.path : "",
        .placement = mukca_capture_placement(c),
        .socket = mukca_capture_socket(c),
        .rows = s->file.n_rows,
        .rows_here = c->socket < 0 ? 0 : mukca_capture_count(c, c->socket),
        .channel = stream->channel,
        .type = mukca_stream_type(r),
        .stream = mukca_recorder_stream(r),
        .rate_hz = age > 1 ? 0 : stream->count.rate,
        .age_s = age,
        .received = stream->count.received,
        .refused = stream->count.refused,
        .still = strcmp(now, "still") == 0,
        .expected_m = s->advice.expected,
        .more_rows_help = s->advice.more_rows_help,
        .n = r->chain->n_joints,
    };
    mukca_capture_spread(&m.spread_m, NULL, c, c->socket);
    for (int j = 0; j < r->chain->n_joints; j++) m.joint[j] = mukca_chain_joint_name(r->chain, j);
    memcpy(m.position, stream->last.reading.q, sizeof m.position);
    mukca_capture_coverage(m.coverage, c);
    mukca_recorder_publish(r, MUKCA_MESSAGE_STATUS, &m);
}
