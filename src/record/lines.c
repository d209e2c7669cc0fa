/* Joint states and triggers as lines on standard input, the recorder's alternative to LCM. */
#include <poll.h>

#include "record/recorder.h"

enum { BURST = 64 /* lines per call */ };

/* Report why the current line cannot be used. */
static void refuse(mukca_recorder *r, const char *text)
{
    mukca_stream *stream = &r->stream;
    const int number = stream->lines->number;
    if (stream->map.made)
        mukca_recorder_refuse(r, MUKCA_RECORDER_MALFORMED, "%s:%d: %s: ignored", stream->channel,
                              number, text);
    else if (!stream->problem.status) /* keep the first reason */
        mukca_fail(&stream->problem, MUKCA_INPUT, "%s:%d: %s", stream->channel, number, text);
}

/* Process one line.  False: the line defined the mapping and stays in the buffer until the mapping
 * is confirmed. */
static bool process_line(mukca_recorder *r, const char *line)
{
    mukca_stream *s = &r->stream;
    mukca_error error;
    mukca_joint_lines *l = s->lines;
    mukca_lcm_packet packet = {.channel = s->channel, .time = l->arrived};
    const bool mapped = s->map.made;
    l->number++;
    switch (mukca_joint_lines_parse(&s->last.joints, l, line, &error)) {
        case MUKCA_LINE_JOINTS:
            if (l->file && s->last.joints.time <= 0) {
                refuse(r, "no time stamp; a recorded stream needs one (column time_s)");
                break;
            }
            if (l->file) packet.time = s->last.joints.time;
            r->packet_time = packet.time;
            mukca_stream_take_joints(r, &packet, 0);
            r->packet_time = 0;
            break;
        case MUKCA_LINE_TRIGGER:
            if (s->connected)
                mukca_sampling_trigger(
                    r, &(mukca_sample_request){
                           .id = l->id, .placement = l->placement, .socket = l->socket});
            break;
        case MUKCA_LINE_FAULT:
            refuse(r, error.text);
            break;
        case MUKCA_LINE_NONE:
            break;
    }
    l->number--;
    if (!mapped && s->map.made) {
        s->count.received = s->last.arrival = 0; /* the line is counted when it is read again */
        return false;
    }
    mukca_joint_lines_take(l);
    return true;
}

mukca_status mukca_stream_wait_lines(mukca_recorder *r, int timeout_ms, int other, bool *readable,
                                     mukca_error *error)
{
    mukca_stream *s = &r->stream;
    mukca_joint_lines *l = s->lines;
    bool ready = false, more = true;
    const char *line = NULL;
    if (readable) *readable = false;
    for (int i = 0; i < BURST && more; i++) {
        const int rows = r->session.file.n_rows;
        line = mukca_joint_lines_peek(l);
        more = line && process_line(r, line) && s->connected && rows == r->session.file.n_rows;
    }
    if (!line && l->ended) return MUKCA_NEGATIVE;
    /* while lines are buffered, poll the link without waiting */
    mukca_status status = mukca_lcm_link_wait(r->link, line ? 0 : timeout_ms, l->fd, &ready, error);
    if (status == MUKCA_OK && ready && !line) mukca_joint_lines_fill(l);
    if (readable && other >= 0) {
        struct pollfd p = {.fd = other, .events = POLLIN};
        *readable = poll(&p, 1, 0) > 0;
    }
    return status;
}
