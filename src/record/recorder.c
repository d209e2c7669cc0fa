/* The recorder's link: finding the channel, type and mapping; silence; what it says and sends. */
#include "record/recorder.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "lcm/description.h"
#include "lcm/state.h"

const char *const recorder_streams[] = {"raw", "corrected", NULL};

enum { SILENCE_US = 2000000, SEARCH_US = 500000, REPEAT_US = 10000000 };

const char *recorder_stream_name(const recorder *r)
{
    return recorder_streams[r->options->stream];
}

void recorder_say(recorder *r, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(r->last_line, sizeof r->last_line, format, args);
    va_end(args);
    if (r->hooks.say) r->hooks.say(r->hooks.context, r->last_line);
}

static void note(void *context, const char *text)
{
    recorder_say(context, "%s", text);
}

void recorder_complain(recorder *r, recorder_trouble kind, const char *text)
{
    int64_t now = mukca_lcm_link_clock(r->link);
    r->times[kind]++;
    if (r->told[kind] && now - r->told[kind] < REPEAT_US && now >= r->told[kind]) return;
    r->told[kind] = now ? now : 1;
    if (r->times[kind] > 1)
        recorder_say(r, "%s (%" PRId64 " times so far)", text, r->times[kind]);
    else
        recorder_say(r, "%s", text);
}

void recorder_refuse(recorder *r, recorder_trouble kind, const char *format, ...)
{
    char text[RECORDER_LINE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    r->refused++;
    recorder_complain(r, kind, text);
}

/* "PANDA_STATUS (drake.lcmt_panda_status, 7 joints), CAMERA (unknown type)" */
static void describe_heard(const recorder *r, char *text, size_t size)
{
    size_t used = 0;
    snprintf(text, size,
             "nothing at all (is the sender on this network, and the multicast route?)");
    for (int i = 0; i < r->n_heard && used < size; i++) {
        const recorder_heard *h = &r->heard[i];
        used += (size_t)snprintf(text + used, size - used, "%s%s (%s", used ? ", " : "", h->channel,
                                 h->type < 0 ? "unknown type" : r->types.type[h->type].name);
        if (h->joints && used < size)
            used += (size_t)snprintf(text + used, size - used, ", %d joints", h->joints);
        if (used < size) used += (size_t)snprintf(text + used, size - used, ")");
    }
}

/* The one channel heard whose messages fit the arm. */
static mukca_status choose_channel(recorder *r)
{
    int fits = -1;
    for (int i = 0; i < r->n_heard; i++) {
        if (r->heard[i].joints < r->model->chain.n_joints) continue;
        if (fits >= 0)
            return mukca_fail(&r->problem, MUKCA_INPUT,
                              "%s and %s both send joint states: choose with --channel",
                              r->heard[fits].channel, r->heard[i].channel);
        fits = i;
    }
    if (fits < 0) return MUKCA_OK;
    memcpy(r->channel, r->heard[fits].channel, sizeof r->channel);
    return mukca_lcm_link_listen(r->link, r->channel, &r->problem);
}

/* ---- the link ---- */

static mukca_status open_link(recorder *r)
{
    mukca_error *error = &r->call->error;
    mukca_status status =
        mukca_lcm_link_open(&r->link, r->options->lcm_url, recorder_on_packet, r, error);
    r->received = r->refused = r->last_arrival = r->rate_since = r->rate_count = 0;
    r->n_heard = 0;
    r->fit_heard = 0;
    memset(r->told, 0, sizeof r->told);
    memset(r->times, 0, sizeof r->times);
    if (!status && r->channel[0]) status = mukca_lcm_link_listen(r->link, r->channel, error);
    if (!status && r->takes_triggers)
        status = mukca_lcm_link_listen(r->link, r->trigger_channel, error);
    if (!status && r->hooks.packet)
        status = mukca_lcm_link_listen(r->link, r->command_channel, error);
    if (!status && !r->mapped) status = mukca_lcm_link_listen(r->link, NULL, error);
    r->listens_to_all = !r->mapped;
    r->opened = status ? 0 : mukca_lcm_link_clock(r->link);
    return status;
}

static mukca_status read_types(recorder *r)
{
    const recorder_options *o = r->options;
    mukca_error *error = &r->call->error;
    mukca_status status = mukca_lcm_types_init(&r->types, error);
    if (!status && o->types.n && !o->position)
        return mukca_fail(error, MUKCA_USAGE,
                          "--type needs --position FIELD: which field holds the joint positions?");
    if (!status && !o->types.n && (o->position || o->names))
        return mukca_fail(error, MUKCA_USAGE, "--position and --names belong to a --type FILE.lcm");
    for (int i = 0; i < o->types.n && !status; i++)
        status = mukca_lcm_types_read(&r->types, o->types.items[i], error);
    /* the struct that has the field: the last such one, as files come in order of need */
    int found = -1;
    for (int t = r->types.n_types - 1; t >= MUKCA_LCM_STATES && found < 0 && !status; t--)
        if (!mukca_lcm_type_set_role(&r->types, t, MUKCA_LCM_ROLE_POSITION, o->position, error))
            found = t;
    if (status || !o->types.n) return status;
    if (found < 0) return MUKCA_INPUT; /* told by the last attempt */
    mukca_error unsaid;
    if (mukca_lcm_type_set_role(&r->types, found, MUKCA_LCM_ROLE_TIME, "utime", &unsaid))
        (void)mukca_lcm_type_set_role(&r->types, found, MUKCA_LCM_ROLE_TIME, "timestamp", &unsaid);
    return o->names
               ? mukca_lcm_type_set_role(&r->types, found, MUKCA_LCM_ROLE_NAME, o->names, error)
               : MUKCA_OK;
}

mukca_status recorder_open(recorder *r, cli_call *call, const recorder_options *options,
                           const cli_model *model, bool takes_triggers, const recorder_hooks *hooks)
{
    memset(r, 0, sizeof *r);
    r->call = call;
    r->options = options;
    r->model = model;
    r->hooks = *hooks;
    r->takes_triggers = takes_triggers;
    r->type = -1;
    mukca_status status = read_types(r);
    if (!status) status = recorder_prepare(r);
    if (status) return status;
    status = recorder_check_map(r);
    if (options->channel && strlen(options->channel) >= sizeof r->channel)
        return mukca_fail(&call->error, MUKCA_USAGE, "--channel: at most 63 characters");
    if (options->channel) memcpy(r->channel, options->channel, strlen(options->channel) + 1);
    mukca_message_channel(r->trigger_channel, MUKCA_MESSAGE_TRIGGER, r->options->prefix);
    mukca_message_channel(r->command_channel, MUKCA_MESSAGE_COMMAND, r->options->prefix);
    return status ? status : open_link(r);
}

mukca_status recorder_connect(recorder *r, double wait)
{
    mukca_error *error = &r->call->error;
    mukca_status status = MUKCA_OK;
    int64_t found = 0; /* us, when the first problem was: a good message may follow */
    while (!status && !r->mapped) {
        status = recorder_step(r, 100, -1, NULL);
        if (r->problem.status && !found) found = mukca_lcm_link_clock(r->link);
        if (r->problem.status && mukca_lcm_link_clock(r->link) - found > 1000000) break;
        if (cli_interrupted()) return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        if (!mukca_lcm_link_replays(r->link) && wait >= 0 &&
            1e-6 * (double)(mukca_lcm_link_clock(r->link) - r->opened) > wait)
            status = MUKCA_NEGATIVE;
    }
    if (status == MUKCA_TRANSPORT) return status;
    if (r->problem.status && !r->mapped) {
        *error = r->problem;
        return r->problem.status;
    }
    if (status == MUKCA_NEGATIVE) {
        char heard[RECORDER_LINE - 100];
        describe_heard(r, heard, sizeof heard);
        return mukca_fail(error, MUKCA_TRANSPORT, "no joint state%s%s; heard: %s",
                          r->channel[0] ? " on " : "", r->channel, heard);
    }
    r->connected = true;
    if (!mukca_lcm_link_replays(r->link)) return MUKCA_OK;
    mukca_lcm_link_close(r->link); /* what was read ahead is to be recorded, too */
    r->link = NULL;
    return open_link(r);
}

mukca_status recorder_step(recorder *r, int timeout_ms, int other, bool *readable)
{
    mukca_status status =
        mukca_lcm_link_wait(r->link, timeout_ms, other, readable, &r->call->error);
    int64_t now = mukca_lcm_link_clock(r->link);
    bool replays = mukca_lcm_link_replays(r->link), ended = status == MUKCA_NEGATIVE;
    if (!r->channel[0] && r->fit_heard && (ended || now - r->fit_heard > SEARCH_US)) {
        mukca_status chosen = choose_channel(r);
        if (chosen) return chosen == MUKCA_TRANSPORT ? chosen : status;
        if (replays) { /* from the start, with the channel known */
            mukca_lcm_link_close(r->link);
            r->link = NULL;
            return open_link(r);
        }
    }
    if (replays || status) return status;
    if (r->mapped && r->confirmed) r->connected = true;
    int64_t age = now - (r->last_arrival ? r->last_arrival : r->opened);
    if (r->mapped && r->listens_to_all && age < SILENCE_US / 2) {
        mukca_lcm_link_unlisten_all(r->link);
        r->listens_to_all = false;
    } else if (!r->listens_to_all && age >= SILENCE_US / 2) { /* what is there instead? */
        r->n_heard = 0;
        r->listens_to_all = mukca_lcm_link_listen(r->link, NULL, &r->call->error) == MUKCA_OK;
    }
    if (!r->silent && age >= SILENCE_US - 200000) { /* said within 2 s */
        char heard[RECORDER_LINE - 100];
        r->silent = true;
        describe_heard(r, heard, sizeof heard);
        recorder_say(r, "no joint state%s%s for %.1f s; heard instead: %s",
                     r->channel[0] ? " on " : "", r->channel, 1e-6 * (double)age, heard);
    }
    return MUKCA_OK;
}

double recorder_age(const recorder *r)
{
    if (!r->last_arrival) return HUGE_VAL;
    /* a trigger is as old as it was when it came, so that a replay decides alike */
    int64_t now = r->packet_time ? r->packet_time : mukca_lcm_link_clock(r->link);
    double age = 1e-6 * (double)(now - r->last_arrival);
    return age > 0 ? age : 0;
}

mukca_status recorder_keep_log(recorder *r)
{
    if (!r->options->record) return MUKCA_OK;
    return mukca_lcm_link_record(r->link, r->options->record, r->call->common->force, note, r,
                                 &r->call->error);
}

/* ---- publishing ---- */

void recorder_publish(recorder *r, mukca_message_kind kind, const void *message)
{
    char channel[64];
    void *buffer = r->outgoing, *more = NULL;
    size_t size = mukca_message_encode(r->outgoing, sizeof r->outgoing, kind, message);
    if (size > sizeof r->outgoing) { /* a result with its JSON */
        buffer = more = malloc(size);
        if (more) mukca_message_encode(more, size, kind, message);
    }
    if (!size || !buffer) return;
    mukca_message_channel(channel, kind, r->options->prefix);
    mukca_error error;
    if (mukca_lcm_link_publish(r->link, channel, buffer, size, &error))
        recorder_complain(r, RECORDER_OWN_MESSAGE, error.text);
    free(more);
}
