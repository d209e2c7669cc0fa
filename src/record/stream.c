/* Packets of the recorder: joint states, triggers, other channels. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "lcm/wire.h"
#include "record/recorder.h"

/* Whether q is plausible as a reading of joint j.  No arm turns a joint by two turns from zero or
 * moves one by 20 m: such values are degrees, or another field. */
static bool plausible(const mukca_recorder *r, int j, double q)
{
    const mukca_chain *chain = r->chain;
    bool linear = chain->element[chain->joint_element[j]].type == MUKCA_PRISMATIC;
    return fabs(q) <= (linear ? 20 : 4 * M_PI);
}

static void copy_values(double *out, const mukca_recorder *r, mukca_lcm_role role)
{
    for (int j = 0; j < r->chain->n_joints; j++) out[j] = r->joints.value[role][r->map[j]];
}

static void count_arrival(mukca_recorder *r, int64_t now)
{
    if (r->last_arrival) {
        double pause = 1e-6 * (double)(now - r->last_arrival);
        if (pause > r->longest_gap) r->longest_gap = pause;
        if (r->silence_reported)
            mukca_recorder_report(r, "%s is back after %.1f s", r->channel, pause);
        if (r->silent && !r->silence_reported) r->occurrences[MUKCA_RECORDER_SILENT]++;
    }
    r->silent = r->silence_reported = false;
    r->last_arrival = now;
    r->received++;
    r->rate_count++;
    if (now - r->rate_since >= 500000 || now < r->rate_since) {
        if (r->rate_since && now > r->rate_since)
            r->rate = 1e6 * (double)r->rate_count / (double)(now - r->rate_since);
        r->rate_since = now;
        r->rate_count = 0;
    }
}

static void feed(mukca_recorder *r, int64_t time)
{
    mukca_capture_reading reading = {
        .time = 1e-6 * (double)time,
        .arrival = 1e-6 * (double)r->last_arrival,
        .q = r->q,
        .effort = r->joints.has[MUKCA_LCM_ROLE_EFFORT] ? r->effort : NULL,
        .command = r->joints.has[MUKCA_LCM_ROLE_COMMAND] ? r->command : NULL,
        .guided = r->joints.guided};
    unsigned found = mukca_capture_feed(&r->capture, &reading);
    if (found & MUKCA_CAPTURE_TWO_SENDERS)
        mukca_recorder_warn(
            r, MUKCA_RECORDER_TWO_SENDERS,
            "two arms seem to send on this channel: stop one of them, or name another --channel");
    else if (found & MUKCA_CAPTURE_BACKWARDS && r->capture.jumps < 2)
        mukca_recorder_warn(r, MUKCA_RECORDER_BACKWARDS,
                            "the sender's clock went back (restarted?): going on with it");
    if (found & MUKCA_CAPTURE_PAUSE && mukca_lcm_link_replays(r->link))
        mukca_recorder_report(r, "%s paused for %.1f s", r->channel, r->capture.pause);
    if (!r->options->still || !r->session.fd) return;
    char text[MUKCA_CAPTURE_TEXT];
    mukca_error answer;
    int socket;
    if (mukca_capture_due(&socket, text, &r->capture)) {
        const mukca_recorder_request due = {.socket = r->capture.rows.sockets[socket].label};
        mukca_recorder_sample(r, &due, &answer);
        mukca_recorder_report(r, "%s", answer.text);
    } else if (text[0]) {
        mukca_recorder_report(r, "%s", text);
    }
}

/* Refuse a message that has no joint states of a known type. */
static void refuse_type(mukca_recorder *r, const mukca_lcm_packet *packet, int type)
{
    uint64_t fingerprint = packet->size < 8 ? 0 : mukca_lcm_wire_get(packet->data, 8);
    const char *own = mukca_message_identify(packet->data, packet->size);
    if (r->mapped)
        mukca_recorder_refuse(r, MUKCA_RECORDER_TYPE,
                              "%s: a message of another type: ignored (fingerprint %016" PRIx64 ")",
                              r->channel, fingerprint);
    else if (type >= 0 || own)
        mukca_fail(&r->problem, MUKCA_INPUT,
                   "%s sends %s, which has no joint positions: name another --channel", r->channel,
                   own ? own : r->types.type[type].name);
    else
        mukca_fail(&r->problem, MUKCA_INPUT,
                   "%s sends a type that mukca does not know (fingerprint %016" PRIx64
                   "): describe it with --type FILE.lcm --position FIELD",
                   r->channel, fingerprint);
}

/* Set the mapping from the first valid message. */
static bool map_first(mukca_recorder *r, int type)
{
    if (mukca_recorder_make_map(r) != MUKCA_OK) return false;
    r->type = type;
    r->n_readings = r->joints.n;
    r->mapped = true;
    r->confirmed = !mukca_recorder_needs_confirmation(r);
    r->problem.status = MUKCA_OK;
    return true;
}

/* Find the mapped names in the message, at their previous positions or elsewhere (a driver may list
 * joints in any order, mixed with others). */
static bool find_names(mukca_recorder *r)
{
    const int n = r->joints.has[MUKCA_LCM_ROLE_NAME] ? r->joints.n : 0;
    for (int j = 0; j < r->chain->n_joints; j++) {
        const char *joint = mukca_recorder_joint(r, j);
        if (r->map[j] < n && strcmp(r->joints.name[r->map[j]], joint) == 0) continue;
        int k = 0;
        while (k < n && strcmp(r->joints.name[k], joint) != 0) k++;
        if (k == n) return false;
        r->map[j] = k;
    }
    return true;
}

/* Copy the message's readings to the arm's joints; false: they are not plausible. */
static bool copy_readings(mukca_recorder *r)
{
    if (r->by_name && !find_names(r)) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_NAMES,
                              "%s: a message without all joints of the arm: ignored (of another "
                              "arm, or of a gripper alone?)",
                              r->channel);
        return false;
    }
    if (!r->by_name && r->joints.n != r->n_readings) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_COUNT,
                              "%s: a message with %d joints instead of %d: ignored (another arm on "
                              "this channel?)",
                              r->channel, r->joints.n, r->n_readings);
        return false;
    }
    for (int j = 0; j < r->chain->n_joints; j++) {
        const char *joint = mukca_recorder_joint(r, j);
        double q = r->joints.value[MUKCA_LCM_ROLE_POSITION][r->map[j]];
        if (!plausible(r, j, q)) {
            mukca_recorder_refuse(r, MUKCA_RECORDER_RANGE,
                                  "%s: %s reads %g: no angle in rad (degrees? wrong --map?)",
                                  r->channel, joint, q);
            return false;
        }
        r->q[j] = q;
    }
    if (r->joints.has[MUKCA_LCM_ROLE_EFFORT]) copy_values(r->effort, r, MUKCA_LCM_ROLE_EFFORT);
    if (r->joints.has[MUKCA_LCM_ROLE_COMMAND]) copy_values(r->command, r, MUKCA_LCM_ROLE_COMMAND);
    return true;
}

static void on_joints(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    mukca_error error;
    int type = mukca_lcm_types_find(&r->types, packet->data, packet->size);
    if (!mukca_lcm_type_has_joints(&r->types, type)) {
        refuse_type(r, packet, type);
        return;
    }
    if (r->mapped && type != r->type) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_TYPE, "%s now sends %s, too: ignored", r->channel,
                              r->types.type[type].name);
        return;
    }
    if (mukca_lcm_decode_joints(&r->joints, &r->types, type, packet->data, packet->size, &error)) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_MALFORMED, "%s: %s: ignored", r->channel,
                              error.text);
        return;
    }
    mukca_recorder_take_joints(r, packet, type);
}

void mukca_recorder_take_joints(mukca_recorder *r, const mukca_lcm_packet *packet, int type)
{
    if (!r->mapped && !map_first(r, type)) return;
    if (!copy_readings(r) || !mukca_recorder_one_sender(r, packet)) return;
    const int64_t time = r->joints.time > 0 ? r->joints.time : packet->time;
    r->state_time = time;
    bool use = r->connected && r->confirmed;
    if (use && r->hooks.joints) r->hooks.joints(r->hooks.context, time, r->q);
    count_arrival(r, packet->time);
    if (use) feed(r, time);
}

static void on_trigger(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    mukca_message_trigger trigger;
    mukca_error error;
    if (mukca_message_decode(&trigger, MUKCA_MESSAGE_TRIGGER, packet->data, packet->size, &error)) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_OWN_MESSAGE, "%s: %s: ignored", packet->channel,
                              error.text);
        return;
    }
    if (!mukca_recorder_may_request(r, packet)) return;
    mukca_status status = mukca_recorder_check_signature(r, packet, trigger.utime, &error);
    if (status == MUKCA_OK && r->hooks.trigger)
        status = r->hooks.trigger(r->hooks.context, packet, &error);
    if (status != MUKCA_OK) {
        mukca_recorder_refuse(r, MUKCA_RECORDER_OWN_MESSAGE, "%s: %s", packet->channel, error.text);
        mukca_recorder_refuse_sample(r, trigger.id, error.text);
        return;
    }
    const mukca_recorder_request request = {.id = trigger.id,
                                            .time = packet->time,
                                            .sent = trigger.utime,
                                            .placement = trigger.placement,
                                            .socket = trigger.socket};
    mukca_recorder_sample(r, &request, &error);
    mukca_recorder_report(r, "%s", error.text);
}

/* Register other channels. */
static void hear(mukca_recorder *r, const mukca_lcm_packet *packet)
{
    if (mukca_message_identify(packet->data, packet->size)) return;
    for (int i = 0; i < r->n_heard; i++)
        if (strcmp(r->heard[i].channel, packet->channel) == 0) return;
    if (r->n_heard == MUKCA_RECORDER_MAX_HEARD) return;
    mukca_recorder_heard *h = &r->heard[r->n_heard++];
    mukca_lcm_joints joints;
    mukca_error none; /* a malformed message counts as one without joints */
    snprintf(h->channel, sizeof h->channel, "%s", packet->channel);
    h->type = mukca_lcm_types_find(&r->types, packet->data, packet->size);
    h->joints = 0;
    if (mukca_lcm_type_has_joints(&r->types, h->type) &&
        mukca_lcm_decode_joints(&joints, &r->types, h->type, packet->data, packet->size, &none) ==
            MUKCA_OK)
        h->joints = joints.n;
    if (h->joints >= r->chain->n_joints && !r->fit_heard) r->fit_heard = packet->time;
}

void mukca_recorder_receive(void *context, const mukca_lcm_packet *packet)
{
    mukca_recorder *r = context;
    bool ahead = mukca_lcm_link_replays(r->link) && !r->connected; /* it will be replayed */
    r->packet_time = packet->time;
    if (strcmp(packet->channel, r->channel) == 0)
        on_joints(r, packet);
    else if (r->options->triggers && strcmp(packet->channel, r->trigger_channel) == 0 && !ahead)
        on_trigger(r, packet);
    else if (r->hooks.command && strcmp(packet->channel, r->command_channel) == 0 && !ahead)
        r->hooks.command(r->hooks.context, packet);
    else
        hear(r, packet);
    r->packet_time = 0;
}
