/* Transport of LCM messages: one interface to networks and logs. */
#include "lcm/link.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "lcm/log.h"

enum { MAX_CHANNELS = 8, BURST = 256 /* events of a log per call */ };

struct mukca_lcm_link {
    mukca_lcm_receiver *network; /* NULL: a log is replayed */
    bool listens_to_all;
    int n_channels;
    char channel[MAX_CHANNELS][64];
    mukca_lcm_packet_fn *receive;
    void *context;
    mukca_lcm_log log;     /* replayed */
    mukca_lcm_event event; /* of the log, read but not delivered */
    bool pending, started;
    double speed;              /* of the replay; 0: as fast as possible */
    int64_t clock;             /* time of the last event delivered, us */
    int64_t first, first_wall; /* time of the log's first event, and of its replay */
    mukca_lcm_log record;
    int64_t flushed;    /* us, last flush of the record */
    mukca_error failed; /* why the record was closed */
    mukca_note_fn *note;
    void *note_context;
};

int64_t mukca_lcm_link_clock(const mukca_lcm_link *link)
{
    return link->network ? mukca_clock_wall() : link->clock;
}

bool mukca_lcm_link_replays(const mukca_lcm_link *link)
{
    return !link->network;
}

int64_t mukca_lcm_link_skipped(const mukca_lcm_link *link)
{
    return link->log.skipped;
}

int64_t mukca_lcm_link_dropped(mukca_lcm_link *link, char reason[128])
{
    return link->network ? mukca_lcm_receiver_dropped(link->network, reason) : 0;
}

/* ---- record ---- */

mukca_status mukca_lcm_link_record(mukca_lcm_link *link, const char *path, bool force,
                                   mukca_note_fn *note, void *note_context, mukca_error *error)
{
    link->note = note;
    link->note_context = note_context;
    return mukca_lcm_log_create(&link->record, path, force, error);
}

static void record(mukca_lcm_link *link, const mukca_lcm_packet *packet)
{
    if (!link->record.file) return;
    mukca_error *error = &link->failed;
    mukca_status status = mukca_lcm_log_write(&link->record, packet->channel, packet->time,
                                              packet->data, packet->size, error);
    if (!status && (packet->time - link->flushed > 500000 || packet->time < link->flushed)) {
        status = mukca_lcm_log_flush(&link->record, error);
        link->flushed = packet->time;
    }
    if (status) {
        mukca_lcm_log_close(&link->record);
        if (link->note) link->note(link->note_context, error->text);
    }
}

mukca_status mukca_lcm_link_finish_record(mukca_lcm_link *link, mukca_error *error)
{
    if (link->record.file) return mukca_lcm_log_finish(&link->record, error);
    if (link->failed.status) *error = link->failed;
    return link->failed.status;
}

static bool is_named(const mukca_lcm_link *link, const char *channel)
{
    for (int i = 0; i < link->n_channels; i++)
        if (strcmp(link->channel[i], channel) == 0) return true;
    return false;
}

/* Deliver a message; named channels are recorded, others are not. */
static void deliver(mukca_lcm_link *link, const mukca_lcm_packet *packet, bool named)
{
    if (named) record(link, packet);
    link->receive(link->context, packet);
}

/* Handler of network messages.  Those of a named channel may arrive by both subscriptions. */
static void on_packet(void *context, const mukca_lcm_packet *packet, bool all)
{
    mukca_lcm_link *link = context;
    if (!all || !is_named(link, packet->channel)) deliver(link, packet, !all);
}

/* ---- open and close ---- */

static mukca_status open_log(mukca_lcm_link *link, const char *url, mukca_error *error)
{
    const char *path = url + strlen("file://");
    size_t length = strcspn(path, "?");
    char name[1024];
    if (length == 0 || length >= sizeof name)
        return mukca_fail(error, MUKCA_USAGE, "\"%.80s\" names no log: file://PATH", url);
    memcpy(name, path, length);
    name[length] = '\0';
    if (path[length]) {
        char *end = NULL;
        if (strncmp(path + length, "?speed=", 7) == 0)
            link->speed = strtod(path + length + 7, &end);
        if (!end || *end || !(link->speed >= 0 && link->speed <= 1e6))
            return mukca_fail(
                error, MUKCA_USAGE,
                "\"%.80s\": the only option of a log is speed=NUMBER (0: as fast as possible)",
                url);
    }
    return mukca_lcm_log_open(&link->log, name, error);
}

mukca_status mukca_lcm_link_open(mukca_lcm_link **out, const mukca_lcm_network *network,
                                 mukca_lcm_packet_fn *receive, void *context, mukca_error *error)
{
    const char *url = network->url;
    if (!url) url = getenv("LCM_DEFAULT_URL");
    if (url && !*url) url = NULL;
    const mukca_lcm_network named = {url, network->interface, network->from};
    mukca_lcm_link *link = calloc(1, sizeof *link);
    *out = NULL;
    if (!link) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    link->receive = receive;
    link->context = context;
    mukca_status status = MUKCA_OK;
    if (url && strncmp(url, "file://", 7) == 0) {
        status = open_log(link, url, error);
    } else {
        status = mukca_lcm_receiver_open(&link->network, &named, on_packet, link, error);
    }
    if (status != MUKCA_OK) {
        mukca_lcm_link_close(link);
        return status;
    }
    *out = link;
    return MUKCA_OK;
}

void mukca_lcm_link_close(mukca_lcm_link *link)
{
    if (!link) return;
    mukca_lcm_receiver_close(link->network);
    mukca_lcm_log_close(&link->log);
    mukca_lcm_log_close(&link->record);
    free(link);
}

/* ---- listen ---- */

mukca_status mukca_lcm_link_listen(mukca_lcm_link *link, const char *channel, mukca_error *error)
{
    if (channel ? is_named(link, channel) : link->listens_to_all) return MUKCA_OK;
    if (channel && (strlen(channel) >= sizeof link->channel[0] || !channel[0]))
        return mukca_fail(error, MUKCA_USAGE, "\"%.70s\" is no channel: 1 to 63 characters",
                          channel);
    if (channel && link->n_channels == MAX_CHANNELS)
        return mukca_fail(error, MUKCA_USAGE, "more than %d channels", MAX_CHANNELS);
    if (link->network) {
        mukca_status status = mukca_lcm_receiver_subscribe(link->network, channel, error);
        if (status != MUKCA_OK) return status;
    }
    if (channel)
        memcpy(link->channel[link->n_channels++], channel, strlen(channel) + 1);
    else
        link->listens_to_all = true;
    return MUKCA_OK;
}

void mukca_lcm_link_unlisten_all(mukca_lcm_link *link)
{
    if (link->network) mukca_lcm_receiver_unsubscribe_all(link->network);
    link->listens_to_all = false;
}

/* ---- wait ---- */

/* Wait for `other` only. */
static void wait_other(int other, bool *readable, int timeout_ms)
{
    struct pollfd p = {.fd = other, .events = POLLIN};
    bool ready = poll(&p, 1, timeout_ms) > 0;
    if (readable) *readable = ready;
}

static mukca_status replay(mukca_lcm_link *link, int timeout_ms, int other, bool *readable,
                           mukca_error *error)
{
    for (int i = 0; i < BURST; i++) {
        if (!link->pending && !(link->pending = mukca_lcm_log_read(&link->log, &link->event)))
            return link->log.exhausted ? mukca_fail(error, MUKCA_MEMORY,
                                                    "LCM log %s: out of memory", link->log.path)
                                       : MUKCA_NEGATIVE;
        if (!link->started) {
            link->started = true;
            link->first = link->event.time;
            link->first_wall = mukca_clock_wall();
        }
        if (link->speed > 0) {
            double wait = (double)(link->event.time - link->first) / link->speed -
                          (double)(mukca_clock_wall() - link->first_wall);
            if (wait > 1000) {
                wait_other(other, readable,
                           wait > 1e3 * timeout_ms ? timeout_ms : (int)(wait / 1e3));
                return MUKCA_OK;
            }
        }
        link->pending = false;
        link->clock = link->event.time;
        bool named = is_named(link, link->event.channel);
        mukca_lcm_packet packet = {.channel = link->event.channel,
                                   .data = link->event.data,
                                   .size = link->event.size,
                                   .time = link->event.time};
        if (named || link->listens_to_all) deliver(link, &packet, named);
    }
    if (other >= 0) wait_other(other, readable, 0);
    return MUKCA_OK;
}

mukca_status mukca_lcm_link_wait(mukca_lcm_link *link, int timeout_ms, int other, bool *readable,
                                 mukca_error *error)
{
    if (readable) *readable = false;
    if (!link->network) return replay(link, timeout_ms, other, readable, error);
    struct pollfd p[2] = {{.fd = mukca_lcm_receiver_descriptor(link->network), .events = POLLIN},
                          {.fd = other, .events = POLLIN}};
    int n = poll(p, 2, timeout_ms);
    if (n < 0 && errno != EINTR)
        return mukca_fail(error, MUKCA_TRANSPORT, "waiting for LCM: %s", strerror(errno));
    if (n <= 0) return MUKCA_OK;
    if (readable && p[1].revents) *readable = true;
    return p[0].revents ? mukca_lcm_receiver_handle(link->network, error) : MUKCA_OK;
}

mukca_status mukca_lcm_link_publish(mukca_lcm_link *link, const char *channel, const void *data,
                                    size_t size, mukca_error *error)
{
    mukca_lcm_packet packet = {
        .channel = channel, .data = data, .size = size, .time = mukca_lcm_link_clock(link)};
    record(link, &packet);
    return link->network ? mukca_lcm_receiver_publish(link->network, &packet, error) : MUKCA_OK;
}
