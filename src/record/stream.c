/* The recorder's messages: joint states to readings, triggers, what else is heard. */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "lcm/wire.h"
#include "record/recorder.h"

/* Joint j as one of its readings; false where it can be none. */
static bool plausible(const recorder *r, int j, double q)
{
    const mukca_chain *chain = &r->model->chain;
    bool linear = chain->element[chain->joint_element[j]].type == MUKCA_PRISMATIC;
    return fabs(q) <= (linear ? 20 : 4 * M_PI);
}

static void take_values(double *out, const recorder *r, mukca_lcm_role role)
{
    for (int j = 0; j < r->model->chain.n_joints; j++) out[j] = r->joints.value[role][r->map[j]];
}

static void count_arrival(recorder *r, int64_t now)
{
    if (r->last_arrival) {
        double gap = 1e-6 * (double)(now - r->last_arrival);
        if (gap > r->longest_gap) r->longest_gap = gap;
        if (r->silent) recorder_say(r, "%s is back after %.1f s", r->channel, gap);
    }
    r->silent = false;
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

static void feed(recorder *r, int64_t time)
{
    mukca_capture_reading reading = {
        .time = 1e-6 * (double)time,
        .q = r->q,
        .effort = r->joints.has[MUKCA_LCM_ROLE_EFFORT] ? r->effort : NULL,
        .command = r->joints.has[MUKCA_LCM_ROLE_COMMAND] ? r->command : NULL,
        .guided = r->joints.guided};
    unsigned found = mukca_capture_feed(&r->capture, &reading);
    if (found & MUKCA_CAPTURE_TWO_SENDERS)
        recorder_complain(
            r, RECORDER_TWO_SENDERS,
            "two arms seem to send on this channel: stop one of them, or name another --channel");
    else if (found & MUKCA_CAPTURE_BACKWARDS && r->capture.jumps < 2)
        recorder_complain(r, RECORDER_BACKWARDS,
                          "the sender's clock went back (restarted?): going on with it");
    if (found & MUKCA_CAPTURE_PAUSE && mukca_lcm_link_replays(r->link))
        recorder_say(r, "%s paused for %.1f s", r->channel, r->capture.pause);
    if (!r->options->still || !r->session.fd) return;
    char text[RECORDER_LINE];
    int socket;
    if (mukca_capture_due(&socket, text, &r->capture)) {
        const mukca_socket *s = &r->capture.rows.sockets[socket];
        recorder_take(r, 0, NULL, s->label, text);
    }
    if (text[0]) recorder_say(r, "%s", text);
}

/* A message that holds no joint states that we know of. */
static void refuse_type(recorder *r, const mukca_lcm_packet *packet, int type)
{
    uint64_t fingerprint = packet->size < 8 ? 0 : mukca_lcm_wire_get(packet->data, 8);
    const char *own = mukca_message_identify(packet->data, packet->size);
    if (r->mapped)
        recorder_refuse(r, RECORDER_TYPE,
                        "%s: a message of another type: ignored (fingerprint %016" PRIx64 ")",
                        r->channel, fingerprint);
    else if (type >= 0 || own)
        mukca_fail(&r->problem, MUKCA_INPUT,
                   "%s sends %s, which holds no joint positions: name another --channel",
                   r->channel, own ? own : r->types.type[type].name);
    else
        mukca_fail(&r->problem, MUKCA_INPUT,
                   "%s sends a type that mukca does not know (fingerprint %016" PRIx64
                   "): describe it with --type FILE.lcm --position FIELD",
                   r->channel, fingerprint);
}

static void on_joints(recorder *r, const mukca_lcm_packet *packet)
{
    mukca_error error;
    int type = mukca_lcm_types_find(&r->types, packet->data, packet->size);
    if (!mukca_lcm_type_has_joints(&r->types, type)) {
        refuse_type(r, packet, type);
        return;
    }
    if (r->mapped && type != r->type) {
        recorder_refuse(r, RECORDER_TYPE, "%s now sends %s, too: ignored", r->channel,
                        r->types.type[type].name);
        return;
    }
    if (mukca_lcm_decode_joints(&r->joints, &r->types, type, packet->data, packet->size, &error)) {
        recorder_refuse(r, RECORDER_MALFORMED, "%s: %s: ignored", r->channel, error.text);
        return;
    }
    if (!r->mapped) {
        if (recorder_make_map(r)) return;
        r->type = type;
        r->n_readings = r->joints.n;
        r->mapped = true;
        r->confirmed = !recorder_needs_confirmation(r);
        r->problem.status = MUKCA_OK;
    }
    if (r->joints.n != r->n_readings) {
        recorder_refuse(r, RECORDER_COUNT,
                        "%s: a message with %d joints instead of %d: ignored (another "
                        "arm on this channel?)",
                        r->channel, r->joints.n, r->n_readings);
        return;
    }
    for (int j = 0; j < r->model->chain.n_joints; j++) {
        if (r->by_name && strcmp(r->joints.name[r->map[j]], recorder_joint_name(r, j)) != 0) {
            recorder_refuse(r, RECORDER_NAMES,
                            "%s: a message with other joint names: ignored (another arm "
                            "on this channel?)",
                            r->channel);
            return;
        }
        double q = r->joints.value[MUKCA_LCM_ROLE_POSITION][r->map[j]];
        if (!plausible(r, j, q)) {
            recorder_refuse(r, RECORDER_RANGE,
                            "%s: %s reads %g: no angle in rad (degrees? wrong --map?)", r->channel,
                            recorder_joint_name(r, j), q);
            return;
        }
        r->q[j] = q;
    }
    if (r->joints.has[MUKCA_LCM_ROLE_EFFORT]) take_values(r->effort, r, MUKCA_LCM_ROLE_EFFORT);
    if (r->joints.has[MUKCA_LCM_ROLE_COMMAND]) take_values(r->command, r, MUKCA_LCM_ROLE_COMMAND);
    int64_t time = r->joints.time > 0 ? r->joints.time : packet->time;
    bool use = r->connected && r->confirmed;
    if (use && r->hooks.joints) r->hooks.joints(r->hooks.context, time, r->q);
    count_arrival(r, packet->time);
    if (use) feed(r, time);
}

static void on_trigger(recorder *r, const mukca_lcm_packet *packet)
{
    mukca_message_trigger trigger;
    mukca_error error;
    char line[RECORDER_LINE];
    if (mukca_message_decode(&trigger, MUKCA_MESSAGE_TRIGGER, packet->data, packet->size, &error)) {
        recorder_refuse(r, RECORDER_OWN_MESSAGE, "%s: %s: ignored", packet->channel, error.text);
        return;
    }
    recorder_take(r, trigger.id, trigger.placement, trigger.socket, line);
    recorder_say(r, "%s", line);
}

/* Remember what other channels there are. */
static void hear(recorder *r, const mukca_lcm_packet *packet)
{
    int i = 0;
    if (mukca_message_identify(packet->data, packet->size)) return;
    while (i < r->n_heard && strcmp(r->heard[i].channel, packet->channel) != 0) i++;
    if (i == RECORDER_MAX_HEARD) return;
    recorder_heard *h = &r->heard[i];
    if (i == r->n_heard) {
        mukca_lcm_joints joints;
        mukca_error unsaid;
        memset(h, 0, sizeof *h);
        snprintf(h->channel, sizeof h->channel, "%s", packet->channel);
        h->type = mukca_lcm_types_find(&r->types, packet->data, packet->size);
        if (mukca_lcm_type_has_joints(&r->types, h->type) &&
            mukca_lcm_decode_joints(&joints, &r->types, h->type, packet->data, packet->size,
                                    &unsaid) == MUKCA_OK)
            h->joints = joints.n;
        r->n_heard++;
        if (h->joints >= r->model->chain.n_joints && !r->fit_heard) r->fit_heard = packet->time;
    }
    h->count++;
}

void recorder_on_packet(void *context, const mukca_lcm_packet *packet)
{
    recorder *r = context;
    bool ahead = mukca_lcm_link_replays(r->link) && !r->connected; /* it will come again */
    r->packet_time = packet->time;
    if (strcmp(packet->channel, r->channel) == 0)
        on_joints(r, packet);
    else if (r->takes_triggers && strcmp(packet->channel, r->trigger_channel) == 0 && !ahead)
        on_trigger(r, packet);
    else if (r->hooks.packet && strcmp(packet->channel, r->command_channel) == 0 && !ahead)
        r->hooks.packet(r->hooks.context, packet);
    else
        hear(r, packet);
    r->packet_time = 0;
}
