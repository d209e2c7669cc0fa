/* Where LCM messages come from and go to. */
#include "lcm/link.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <lcm/lcm.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "lcm/log.h"

enum { MAX_CHANNELS = 8, BURST = 256 /* events of a log at a time */ };

struct mukca_lcm_link {
    lcm_t *lcm; /* NULL: a log is replayed */
    lcm_subscription_t *all;
    bool listens_to_all;
    int n_channels;
    char channel[MAX_CHANNELS][64];
    mukca_lcm_packet_fn *receive;
    void *context;
    mukca_lcm_log log;     /* replayed */
    mukca_lcm_event event; /* of the log, not handed over yet */
    bool pending, started;
    double speed;              /* of the replay, 0: no waiting */
    int64_t clock;             /* time of the last event handed over, us */
    int64_t first, first_wall; /* time of the log's first event, and when it was replayed */
    mukca_lcm_log record;
    int64_t flushed; /* us */
    mukca_note_fn *note;
    void *note_context;
};

static int64_t wall_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    return (int64_t)t.tv_sec * 1000000 + t.tv_nsec / 1000;
}

int64_t mukca_lcm_link_clock(const mukca_lcm_link *link)
{
    return link->lcm ? wall_clock() : link->clock;
}

bool mukca_lcm_link_replays(const mukca_lcm_link *link)
{
    return !link->lcm;
}

int64_t mukca_lcm_link_skipped(const mukca_lcm_link *link)
{
    return link->log.skipped;
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
            return mukca_fail(error, MUKCA_USAGE,
                              "\"%.80s\": a log takes no option but speed=NUMBER, 0 for no waiting",
                              url);
    }
    return mukca_lcm_log_open(&link->log, name, error);
}

/* lcm_create, whose screenful about a missing route is left to our one line. */
static lcm_t *create_quietly(const char *url)
{
    int silence = open("/dev/null", O_WRONLY | O_CLOEXEC), kept = dup(STDERR_FILENO);
    bool quiet = silence >= 0 && kept >= 0 && dup2(silence, STDERR_FILENO) >= 0;
    lcm_t *lcm = lcm_create(url);
    if (quiet) dup2(kept, STDERR_FILENO);
    if (kept >= 0) close(kept);
    if (silence >= 0) close(silence);
    return lcm;
}

mukca_status mukca_lcm_link_open(mukca_lcm_link **out, const char *url,
                                 mukca_lcm_packet_fn *receive, void *context, mukca_error *error)
{
    if (!url) url = getenv("LCM_DEFAULT_URL");
    if (url && !*url) url = NULL;
    mukca_lcm_link *link = calloc(1, sizeof *link);
    *out = NULL;
    if (!link) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    link->receive = receive;
    link->context = context;
    mukca_status status = MUKCA_OK;
    if (url && strncmp(url, "file://", 7) == 0) {
        status = open_log(link, url, error);
    } else {
        link->lcm = create_quietly(url);
        if (!link->lcm)
            status = mukca_fail(
                error, MUKCA_TRANSPORT,
                "LCM cannot use %.80s: is there a multicast route? For one machine: ip link set lo "
                "multicast on; ip route add 224.0.0.0/4 dev lo",
                url ? url : "its default network");
    }
    if (status) {
        mukca_lcm_link_close(link);
        return status;
    }
    *out = link;
    return MUKCA_OK;
}

void mukca_lcm_link_close(mukca_lcm_link *link)
{
    if (!link) return;
    if (link->lcm) lcm_destroy(link->lcm);
    mukca_lcm_log_close(&link->log);
    mukca_lcm_log_close(&link->record);
    free(link);
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
    mukca_error error;
    mukca_status status = mukca_lcm_log_write(&link->record, packet->channel, packet->time,
                                              packet->data, packet->size, &error);
    if (!status && (packet->time - link->flushed > 500000 || packet->time < link->flushed)) {
        status = mukca_lcm_log_flush(&link->record, &error);
        link->flushed = packet->time;
    }
    if (status) {
        mukca_lcm_log_close(&link->record);
        if (link->note) link->note(link->note_context, error.text);
    }
}

/* Named channels are recorded; what else is heard is not. */
static void hand_over(mukca_lcm_link *link, const mukca_lcm_packet *packet, bool named)
{
    if (named) record(link, packet);
    link->receive(link->context, packet);
}

/* ---- listen ---- */

static bool is_named(const mukca_lcm_link *link, const char *channel)
{
    for (int i = 0; i < link->n_channels; i++)
        if (strcmp(link->channel[i], channel) == 0) return true;
    return false;
}

static void on_named(const lcm_recv_buf_t *buffer, const char *channel, void *link)
{
    mukca_lcm_packet packet = {channel, buffer->data, buffer->data_size, buffer->recv_utime};
    hand_over(link, &packet, true);
}

static void on_any(const lcm_recv_buf_t *buffer, const char *channel, void *link)
{
    mukca_lcm_packet packet = {channel, buffer->data, buffer->data_size, buffer->recv_utime};
    if (!is_named(link, channel)) hand_over(link, &packet, false);
}

mukca_status mukca_lcm_link_listen(mukca_lcm_link *link, const char *channel, mukca_error *error)
{
    char pattern[2 * 64 + 1] = ".*";
    if (channel) {
        if (is_named(link, channel)) return MUKCA_OK;
        if (strlen(channel) >= sizeof link->channel[0] || !channel[0])
            return mukca_fail(error, MUKCA_USAGE, "\"%.70s\" is no channel: 1 to 63 characters",
                              channel);
        if (link->n_channels == MAX_CHANNELS)
            return mukca_fail(error, MUKCA_USAGE, "more than %d channels", MAX_CHANNELS);
        size_t n = 0; /* subscriptions are regular expressions */
        for (const char *c = channel; *c; c++) {
            if (!isalnum((unsigned char)*c) && *c != '_' && (unsigned char)*c < 128)
                pattern[n++] = '\\';
            pattern[n++] = *c;
        }
        pattern[n] = '\0';
    } else if (link->listens_to_all) {
        return MUKCA_OK;
    }
    if (link->lcm) {
        lcm_subscription_t *subscription =
            lcm_subscribe(link->lcm, pattern, channel ? on_named : on_any, link);
        if (!subscription)
            return mukca_fail(error, MUKCA_TRANSPORT,
                              "LCM cannot listen to \"%s\": is multicast blocked by a firewall?",
                              channel ? channel : "all channels");
        lcm_subscription_set_queue_capacity(subscription, 0); /* else it drops beyond 30 */
        if (!channel) link->all = subscription;
    }
    if (channel)
        memcpy(link->channel[link->n_channels++], channel, strlen(channel) + 1);
    else
        link->listens_to_all = true;
    return MUKCA_OK;
}

void mukca_lcm_link_unlisten_all(mukca_lcm_link *link)
{
    if (link->all) lcm_unsubscribe(link->lcm, link->all);
    link->all = NULL;
    link->listens_to_all = false;
}

/* ---- wait ---- */

/* Wait for `other` alone. */
static void wait_other(int other, bool *readable, int timeout_ms)
{
    struct pollfd p = {.fd = other, .events = POLLIN};
    bool ready = poll(&p, 1, timeout_ms) > 0;
    if (readable) *readable = ready;
}

static mukca_status replay(mukca_lcm_link *link, int timeout_ms, int other, bool *readable)
{
    for (int i = 0; i < BURST; i++) {
        if (!link->pending && !(link->pending = mukca_lcm_log_read(&link->log, &link->event)))
            return MUKCA_NEGATIVE;
        if (!link->started) {
            link->started = true;
            link->first = link->event.time;
            link->first_wall = wall_clock();
        }
        if (link->speed > 0) {
            double wait = (double)(link->event.time - link->first) / link->speed -
                          (double)(wall_clock() - link->first_wall);
            if (wait > 1000) {
                wait_other(other, readable,
                           wait > 1e3 * timeout_ms ? timeout_ms : (int)(wait / 1e3));
                return MUKCA_OK;
            }
        }
        link->pending = false;
        link->clock = link->event.time;
        bool named = is_named(link, link->event.channel);
        mukca_lcm_packet packet = {link->event.channel, link->event.data, link->event.size,
                                   link->event.time};
        if (named || link->listens_to_all) hand_over(link, &packet, named);
    }
    if (other >= 0) wait_other(other, readable, 0);
    return MUKCA_OK;
}

mukca_status mukca_lcm_link_wait(mukca_lcm_link *link, int timeout_ms, int other, bool *readable,
                                 mukca_error *error)
{
    if (readable) *readable = false;
    if (!link->lcm) return replay(link, timeout_ms, other, readable);
    struct pollfd p[2] = {{.fd = lcm_get_fileno(link->lcm), .events = POLLIN},
                          {.fd = other, .events = POLLIN}};
    int n = poll(p, 2, timeout_ms);
    if (n < 0 && errno != EINTR)
        return mukca_fail(error, MUKCA_TRANSPORT, "waiting for LCM: %s", strerror(errno));
    if (n <= 0) return MUKCA_OK;
    if (readable && p[1].revents) *readable = true;
    if (p[0].revents && lcm_handle(link->lcm) < 0 && errno != EINTR)
        return mukca_fail(error, MUKCA_TRANSPORT, "LCM stopped receiving");
    return MUKCA_OK;
}

mukca_status mukca_lcm_link_publish(mukca_lcm_link *link, const char *channel, const void *data,
                                    size_t size, mukca_error *error)
{
    mukca_lcm_packet packet = {channel, data, size, mukca_lcm_link_clock(link)};
    record(link, &packet);
    if (link->lcm && lcm_publish(link->lcm, channel, data, (unsigned)size))
        return mukca_fail(error, MUKCA_TRANSPORT, "LCM cannot send on %s", channel);
    return MUKCA_OK;
}
