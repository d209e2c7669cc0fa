/* The joint states of a recording: checks, mapping, one sender at a time. */
#include <inttypes.h>
#include <math.h>
#include <poll.h>

#include "io/rows.h"
#include "record/recorder.h"

/* A restarted driver has a new port and is accepted after this silence, us. */
static const int64_t handover_us = 500000;

static const char two_arms[] =
    "two arms seem to send on this channel: stop one of them, or name another --channel";

/* Take the mapped readings of the message.  Implausible values are degrees, or another field. */
static mukca_status take_positions(mukca_recorder *r, mukca_error *error)
{
    mukca_stream *stream = &r->stream;
    const mukca_chain *chain = r->chain;
    for (int j = 0; j < chain->n_joints; j++) {
        const double q = stream->last.joints.value[MUKCA_LCM_ROLE_POSITION][stream->map.reading[j]];
        if (!mukca_rows_plausible(&chain->element[chain->joint_element[j]], q))
            return mukca_fail(error, MUKCA_INPUT,
                              "%s: %s reads %g: no angle in rad; convert degrees%s, or check --map",
                              stream->channel, mukca_chain_joint_name(r->chain, j), q,
                              stream->lines ? " (a header may say [deg])" : "");
        stream->last.reading.q[j] = q;
    }
    return MUKCA_OK;
}

static void copy_values(double *out, const mukca_stream *stream, int n, mukca_lcm_role role)
{
    const mukca_lcm_joints *joints = &stream->last.joints;
    for (int j = 0; j < n; j++)
        out[j] = joints->has[role] ? joints->value[role][stream->map.reading[j]] : (double)NAN;
}

/* Whether joint states are from the accepted sender.  False: the message is refused. */
static bool one_sender(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    mukca_stream *stream = &r->stream;
    int64_t silence = packet->time - stream->sender.heard;
    if (!packet->sender || !stream->sender.id || stream->sender.id == packet->sender ||
        silence > handover_us || silence < -handover_us) {
        stream->sender.id = packet->sender;
        stream->sender.heard = packet->time;
        return true;
    }
    stream->sender.second_heard = packet->time;
    mukca_recorder_refuse(r, MUKCA_RECORDER_TWO_SENDERS, "%s", two_arms);
    return false;
}

static void count_arrival(mukca_recorder *r, int64_t now)
{
    mukca_stream *stream = &r->stream;
    mukca_stream_count *count = &stream->count;
    mukca_stream_silence *silence = &stream->silence;
    if (stream->last.arrival) {
        const double pause = 1e-6 * (double)(now - stream->last.arrival);
        count->longest_gap = fmax(count->longest_gap, pause);
        if (silence->reported)
            mukca_recorder_report(r, "%s is back after %.1f s", stream->channel, pause);
        else if (silence->begun)
            r->reports.occurrences[MUKCA_RECORDER_SILENT]++;
    }
    silence->begun = silence->reported = false;
    stream->last.arrival = now;
    count->received++;
    count->rate_count++;
    const int64_t period = now - count->rate_since;
    if (period >= 0 && period < 500000) return;
    if (count->rate_since && period > 0)
        count->rate = 1e6 * (double)count->rate_count / (double)period;
    count->rate_since = now;
    count->rate_count = 0;
}

/* Whether the last sample is the only one of its placement, which `socket` is not of: a rest. */
static bool was_rest(const mukca_dataset *rows, int socket)
{
    const int last = rows->n_rows - 1;
    if (last < 0) return false;
    const int placement = mukca_dataset_placement(rows, last);
    for (int i = 0; i < last; i++)
        if (mukca_dataset_placement(rows, i) == placement) return false;
    return socket < 0 || rows->sockets[socket].placement != placement;
}

/* Record a sample if the arm stands still in a socket (--still).  In a recording nobody presses n:
 * a posture elsewhere begins the next placement, or goes on with an earlier one. */
static void record_still(mukca_recorder *r)
{
    const mukca_dataset *rows = &r->session.capture.rows;
    char text[MUKCA_CAPTURE_TEXT];
    mukca_error answer;
    int socket;
    const bool due = mukca_capture_due(&socket, text, &r->session.capture);
    const bool replay = r->stream.lines ? r->stream.lines->file : r->link.replays;
    if (!due && !text[0]) return;
    if (!due && !replay) {
        r->session.refused++;
        mukca_recorder_report(r, "%s", text);
        return;
    }
    const bool rest = replay && was_rest(rows, socket);
    if (rest) {
        mukca_sampling_delete(r, &answer);
        mukca_recorder_report(r, "%s: a rest between placements", answer.text);
    } else if (socket < 0) {
        mukca_sampling_select(r, "", NULL, &answer);
    }
    mukca_message_trigger trigger = {.id = 0};
    if (socket >= 0) {
        trigger.placement = rows->placements[rows->sockets[socket].placement].name;
        trigger.socket = rows->sockets[socket].label;
    }
    mukca_sampling_trigger(r, &trigger, 0);
}

static void feed(mukca_recorder *r, int64_t time)
{
    mukca_stream *stream = &r->stream;
    mukca_capture_reading *reading = &stream->last.reading;
    reading->time = 1e-6 * (double)time;
    reading->arrival = 1e-6 * (double)stream->last.arrival;
    unsigned found = mukca_capture_feed(&r->session.capture, reading);
    if (found & MUKCA_CAPTURE_TWO_SENDERS)
        mukca_recorder_warn(r, MUKCA_RECORDER_TWO_SENDERS, "%s", two_arms);
    else if (found & MUKCA_CAPTURE_BACKWARDS && r->session.capture.jumps < 2)
        mukca_recorder_warn(r, MUKCA_RECORDER_BACKWARDS,
                            "the sender's clock went back (restarted?): going on with it");
    if (!r->options->still || !r->session.file.open) return;
    record_still(r);
}

/* Refuse a message that has no joint states of a known type. */
static void refuse_type(mukca_recorder *r, const mukca_lcm_packet *packet, int type)
{
    mukca_stream *stream = &r->stream;
    uint64_t fingerprint = packet->size < 8 ? 0 : mukca_lcm_wire_get(packet->data, 8);
    const char *own_type = mukca_message_identify(packet->data, packet->size);
    if (stream->map.made)
        mukca_recorder_refuse(r, MUKCA_RECORDER_TYPE,
                              "%s: a message of another type: ignored (fingerprint %016" PRIx64 ")",
                              stream->channel, fingerprint);
    else if (type >= 0 || own_type)
        mukca_fail(&stream->problem, MUKCA_INPUT,
                   "%s sends %s, which has no joint positions: name another --channel",
                   stream->channel, own_type ? own_type : stream->types.type[type].name);
    else
        mukca_fail(&stream->problem, MUKCA_INPUT,
                   "%s sends a type that mukca does not know (fingerprint %016" PRIx64
                   "): describe it with --type FILE.lcm --position FIELD",
                   stream->channel, fingerprint);
}

/* Set the mapping from the first valid message. */
static bool map_first(mukca_recorder *r, int type)
{
    mukca_stream *stream = &r->stream;
    if (mukca_stream_make_map(r) != MUKCA_OK || take_positions(r, &stream->problem) != MUKCA_OK)
        return false;
    stream->type = type;
    stream->map.n = stream->last.joints.n;
    stream->map.made = true;
    stream->map.confirmed = stream->map.by_name || r->options->map;
    stream->problem.status = MUKCA_OK;
    return true;
}

/* Copy the message's readings to the arm's joints; false: they are not plausible. */
static bool copy_readings(mukca_recorder *r)
{
    mukca_stream *stream = &r->stream;
    int missing;
    if (stream->map.by_name && !mukca_stream_find_names(stream, &missing, r->chain->n_joints)) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_NAMES,
                              "%s: a message without all joints of the arm: ignored (of another "
                              "arm, or of a gripper alone?)",
                              stream->channel);
        return false;
    }
    if (!stream->map.by_name && stream->last.joints.n != stream->map.n) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_COUNT,
                              "%s: a message with %d joints instead of %d: ignored (another arm on "
                              "this channel?)",
                              stream->channel, stream->last.joints.n, stream->map.n);
        return false;
    }
    mukca_error error;
    if (take_positions(r, &error) != MUKCA_OK) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_RANGE, "%s", error.text);
        return false;
    }
    copy_values(stream->last.reading.effort, stream, r->chain->n_joints, MUKCA_LCM_ROLE_EFFORT);
    copy_values(stream->last.reading.command, stream, r->chain->n_joints, MUKCA_LCM_ROLE_COMMAND);
    return true;
}

/* Process the joint states in r->stream.last.joints; `packet` has their arrival and sender. */
static void take_joints(mukca_recorder *r, const mukca_lcm_packet *packet, int type)
{
    mukca_stream *stream = &r->stream;
    if (!stream->map.made && !map_first(r, type)) return;
    if (!copy_readings(r) || !one_sender(r, packet)) return;
    const int64_t time = stream->last.joints.time > 0 ? stream->last.joints.time : packet->time;
    stream->last.time = time;
    bool use = stream->connected && stream->map.confirmed;
    if (use && r->hooks.joints) r->hooks.joints(r->hooks.context, time, stream->last.reading.q);
    count_arrival(r, packet->time);
    if (use) feed(r, time);
}

void mukca_stream_take(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    mukca_stream *stream = &r->stream;
    mukca_error error;
    int type = mukca_lcm_types_find(&stream->types, packet->data, packet->size);
    if (!mukca_lcm_type_has_joints(&stream->types, type)) {
        refuse_type(r, packet, type);
        return;
    }
    if (stream->map.made && type != stream->type) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_TYPE, "%s now sends %s, too: ignored",
                              stream->channel, stream->types.type[type].name);
        return;
    }
    if (mukca_lcm_decode_joints(&stream->last.joints, &stream->types, type, packet->data,
                                packet->size, &error)) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_MALFORMED, "%s: %s: ignored", stream->channel,
                              error.text);
        return;
    }
    take_joints(r, packet, type);
}

/* ---- lines of standard input, the alternative to LCM ---- */

enum { BURST = 64 /* lines per call */ };

/* Report why the current line cannot be used. */
static void refuse(mukca_recorder *r, const char *text)
{
    mukca_stream *stream = &r->stream;
    const int number = stream->lines->number + 1;
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
    switch (mukca_joint_lines_parse(&s->last.joints, l, line, &error)) {
        case MUKCA_LINE_JOINTS:
            if (l->file && !l->timed) {
                refuse(r, "no time stamp; a recorded stream needs one (column time_s)");
                break;
            }
            if (l->file) packet.time = s->last.joints.time;
            r->packet_time = packet.time;
            take_joints(r, &packet, 0);
            r->packet_time = 0;
            break;
        case MUKCA_LINE_TRIGGER:
            if (s->connected) mukca_sampling_trigger(r, &l->trigger, 0);
            break;
        case MUKCA_LINE_FAULT:
            refuse(r, error.text);
            break;
        case MUKCA_LINE_NONE:
            break;
    }
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
    mukca_status status =
        mukca_lcm_link_wait(&r->link, line ? 0 : timeout_ms, l->fd, &ready, error);
    if (status == MUKCA_OK && ready && !line) mukca_joint_lines_fill(l);
    if (readable && other >= 0) {
        struct pollfd p = {.fd = other, .events = POLLIN};
        *readable = poll(&p, 1, 0) > 0;
    }
    return status;
}
