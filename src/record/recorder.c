/* The recorder and its link: detection of channel, type, mapping and silence. */
#include "record/recorder.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/text.h"
#include "lcm/description.h"
#include "lcm/state.h"

static const double listen_s = 1, /* our choice: silence before listening to all channels */
    silence_s = 1.8;              /* and before it is reported, within 2 s */

enum {                      /* us, our choice */
       SEARCH_US = 500000,  /* wait for other matching streams after the first */
       PROBLEM_US = 1000000 /* wait for a valid message after an invalid one */
};

/* Select the channel whose messages fit the arm; more than one is an error. */
static mukca_status choose_channel(mukca_recorder *r)
{
    int fits = -1;
    for (int i = 0; i < r->n_heard; i++) {
        if (r->heard[i].joints < r->chain->n_joints) continue;
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

static mukca_status open_link(mukca_recorder *r, mukca_error *error)
{
    mukca_lcm_link_close(r->link);
    r->link = NULL;
    r->received = r->refused = r->last_arrival = r->rate_since = r->rate_count = 0;
    r->dropped = r->second_heard = r->arm_heard = 0;
    r->arm = 0;
    r->n_heard = 0;
    r->fit_heard = 0;
    r->quiet = 0;
    memset(r->reported, 0, sizeof r->reported);
    memset(r->occurrences, 0, sizeof r->occurrences);
    const char *channels[] = {r->channel[0] && !r->lines ? r->channel : NULL,
                              r->options->triggers ? r->trigger_channel : NULL,
                              r->hooks.command ? r->command_channel : NULL};
    mukca_lcm_network network = r->options->network;
    if (r->lines && !r->options->triggers) network = (mukca_lcm_network){.url = "memq://"};
    mukca_status status = mukca_lcm_link_open(&r->link, &network, mukca_recorder_receive, r, error);
    for (int i = 0; i < 3 && !status; i++)
        if (channels[i]) status = mukca_lcm_link_listen(r->link, channels[i], error);
    const bool search = !r->mapped && !r->lines;
    if (!status && search) status = mukca_lcm_link_listen(r->link, NULL, error);
    r->listens_to_all = search;
    r->opened = status ? 0 : mukca_lcm_link_clock(r->link);
    return status;
}

static mukca_status read_types(mukca_recorder *r, mukca_error *error)
{
    const mukca_recorder_options *o = r->options;
    mukca_status status = mukca_lcm_types_init(&r->types, error);
    if (status != MUKCA_OK) return status;
    if (o->n_types && !o->position)
        return mukca_fail(
            error, MUKCA_USAGE,
            "--type needs --position FIELD: which field contains the joint positions?");
    if (!o->n_types && (o->position || o->names))
        return mukca_fail(error, MUKCA_USAGE, "--position and --names belong to a --type FILE.lcm");
    if (!o->n_types) return MUKCA_OK;
    for (int i = 0; i < o->n_types && !status; i++)
        status = mukca_lcm_types_read(&r->types, o->types[i], error);
    if (status != MUKCA_OK) return status;
    /* from the last struct backwards, as nested types come first */
    int t = r->types.n_types;
    do
        status =
            mukca_lcm_type_set_role(&r->types, --t, MUKCA_LCM_ROLE_POSITION, o->position, error);
    while (status != MUKCA_OK && t > MUKCA_LCM_STATES);
    if (status != MUKCA_OK) return status;
    mukca_error none; /* time stamps are optional */
    if (mukca_lcm_type_set_role(&r->types, t, MUKCA_LCM_ROLE_TIME, "utime", &none))
        (void)mukca_lcm_type_set_role(&r->types, t, MUKCA_LCM_ROLE_TIME, "timestamp", &none);
    if (!o->names) return MUKCA_OK;
    return mukca_lcm_type_set_role(&r->types, t, MUKCA_LCM_ROLE_NAME, o->names, error);
}

static mukca_status open_lines(mukca_recorder *r, mukca_error *error)
{
    const mukca_recorder_options *o = r->options;
    if (o->channel || o->n_types || o->log)
        return mukca_fail(error, MUKCA_USAGE,
                          "--stdin reads lines: --channel, --type and --record belong to LCM");
    r->lines = malloc(sizeof *r->lines);
    if (!r->lines) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_joint_lines_open(r->lines, STDIN_FILENO);
    snprintf(r->channel, sizeof r->channel, "standard input");
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
    r->type = -1;
    mukca_status status = read_types(r, error);
    if (status == MUKCA_OK) status = mukca_recorder_prepare(r, theta, error);
    if (status == MUKCA_OK) status = mukca_recorder_check_map(r, error);
    if (status != MUKCA_OK) return status;
    if (options->channel && strlen(options->channel) >= sizeof r->channel)
        return mukca_fail(error, MUKCA_USAGE, "--channel: at most 63 characters");
    if (options->channel) memcpy(r->channel, options->channel, strlen(options->channel) + 1);
    mukca_message_channel(r->trigger_channel, MUKCA_MESSAGE_TRIGGER, options->prefix);
    mukca_message_channel(r->command_channel, MUKCA_MESSAGE_COMMAND, options->prefix);
    if (options->lines) status = open_lines(r, error);
    if (status != MUKCA_OK) return status;
    if (options->key) status = mukca_lcm_key_read(&r->key, options->key, error);
    if (status == MUKCA_OK) status = open_link(r, error);
    /* requests signed before the start may have been accepted by an earlier process */
    if (status == MUKCA_OK && !mukca_lcm_link_replays(r->link)) r->last_signed = r->opened;
    return status;
}

void mukca_recorder_close(mukca_recorder *r)
{
    mukca_session_close(&r->session);
    mukca_capture_free(&r->capture);
    mukca_lcm_link_close(r->link);
    r->link = NULL;
    free(r->lines);
    r->lines = NULL;
}

mukca_status mukca_recorder_connect(mukca_recorder *r, double wait, mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    int64_t found = 0; /* us, time of the first problem */
    while (!status && !r->mapped) {
        status = mukca_recorder_step(r, 100, -1, NULL, error);
        if (!r->link || status == MUKCA_MEMORY) return status; /* reopening failed */
        int64_t now = mukca_lcm_link_clock(r->link);
        if (r->problem.status && !found) found = now;
        if (r->problem.status && now - found > PROBLEM_US) break;
        if (r->hooks.interrupted && r->hooks.interrupted())
            return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted");
        if (!mukca_lcm_link_replays(r->link) && wait >= 0 &&
            1e-6 * (double)(now - r->opened) > wait)
            status = MUKCA_NEGATIVE;
    }
    if (status == MUKCA_TRANSPORT) return status;
    if (r->problem.status && !r->mapped) {
        *error = r->problem;
        return r->problem.status;
    }
    if (status == MUKCA_NEGATIVE && !r->mapped) { /* a short log may end at once */
        char line[MUKCA_RECORDER_LINE];
        mukca_text text = MUKCA_TEXT(line);
        mukca_recorder_describe_silence(&text, r, "");
        return mukca_fail(error, MUKCA_TRANSPORT, "%s", line);
    }
    r->connected = true;
    /* messages read ahead from a log are recorded, too */
    return mukca_lcm_link_replays(r->link) ? open_link(r, error) : MUKCA_OK;
}

/* Detect silence on a network.  It is the time of waiting: a process that was stopped, or is late,
 * has not heard whether the stream goes on. */
static void watch(mukca_recorder *r)
{
    if (r->mapped && r->listens_to_all && r->quiet < listen_s) {
        mukca_lcm_link_unlisten_all(r->link);
        r->listens_to_all = false;
    } else if (!r->lines && !r->listens_to_all && r->quiet >= listen_s) {
        mukca_error none; /* retried at the next step */
        r->n_heard = 0;
        r->listens_to_all = mukca_lcm_link_listen(r->link, NULL, &none) == MUKCA_OK;
    }
    if (r->quiet < silence_s) return;
    r->silent = true;
    if (r->silence_reported || mukca_recorder_reported(r, MUKCA_RECORDER_SILENT)) return;
    char line[MUKCA_RECORDER_LINE], since[40];
    mukca_text text = MUKCA_TEXT(line);
    r->silence_reported = true;
    snprintf(since, sizeof since, " for %.1f s", r->quiet);
    mukca_recorder_describe_silence(&text, r, since);
    mukca_recorder_warn(r, MUKCA_RECORDER_SILENT, line);
}

static void warn_dropped(mukca_recorder *r)
{
    char reason[128], line[160];
    int64_t dropped = mukca_lcm_link_dropped(r->link, reason);
    if (dropped == r->dropped) return;
    r->dropped = dropped;
    snprintf(line, sizeof line, "network: messages dropped: %s", reason);
    mukca_recorder_warn(r, MUKCA_RECORDER_DROPPED, line);
}

mukca_status mukca_recorder_step(mukca_recorder *r, int timeout_ms, int other, bool *readable,
                                 mukca_error *error)
{
    const int64_t received = r->received;
    const double begun = mukca_clock_seconds();
    mukca_status status = r->lines
                              ? mukca_recorder_wait_lines(r, timeout_ms, other, readable, error)
                              : mukca_lcm_link_wait(r->link, timeout_ms, other, readable, error);
    int64_t now = mukca_lcm_link_clock(r->link);
    bool replays = mukca_lcm_link_replays(r->link), ended = status == MUKCA_NEGATIVE;
    if (!r->channel[0] && r->fit_heard && (ended || now - r->fit_heard > SEARCH_US)) {
        mukca_status chosen = choose_channel(r);
        if (chosen == MUKCA_TRANSPORT) *error = r->problem;
        if (chosen != MUKCA_OK) return chosen == MUKCA_TRANSPORT ? chosen : status;
        if (replays) return open_link(r, error); /* restart with the known channel */
    }
    if (replays || status) return status;
    warn_dropped(r);
    if (r->mapped && r->confirmed) r->connected = true;
    r->quiet += fmin(mukca_clock_seconds() - begun, 1e-3 * timeout_ms + 0.1);
    if (r->received != received) r->quiet = 0;
    watch(r);
    return MUKCA_OK;
}

mukca_status mukca_recorder_finish(mukca_recorder *r, mukca_error *error)
{
    mukca_status status = mukca_lcm_link_finish_record(r->link, error);
    if (!r->unwritten) return status;
    return mukca_fail(error, MUKCA_MEMORY, "not all was written (%d failures); the first: %s",
                      r->unwritten, r->first_unwritten.text);
}

mukca_status mukca_recorder_start_log(mukca_recorder *r, mukca_error *error)
{
    if (!r->options->log) return MUKCA_OK;
    return mukca_lcm_link_record(r->link, r->options->log, r->options->force, mukca_recorder_note,
                                 r, error);
}
