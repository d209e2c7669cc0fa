/* Transport of LCM messages: one interface to networks and logs; logs.  A network is received by
 * mukca's own code, as liblcm trusts its input; liblcm sends. */
#include "lcm/link.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <lcm/lcm.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/text.h"
#include "io/output.h"

enum { BURST = 256 /* events of a log per call */ };

int64_t mukca_lcm_link_clock(const mukca_lcm_link *link)
{
    return link->replays ? link->clock : mukca_clock_wall();
}

/* ---- open and close ---- */

/* lcm_create without its long message about a missing route. */
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

/* Parse an IPv4 address text[length]; 0: invalid. */
static uint32_t read_address(const char *text, size_t length)
{
    char copy[16];
    struct in_addr address;
    if (length >= sizeof copy) return 0;
    memcpy(copy, text, length);
    copy[length] = '\0';
    return inet_pton(AF_INET, copy, &address) == 1 ? ntohl(address.s_addr) : 0;
}

/* Parse "udpm://GROUP:PORT?recv_buf_size=N"; each part is optional, other options concern sending.
 * False: invalid. */
static bool read_url(mukca_lcm_multicast_options *options, const char *url)
{
    *options = (mukca_lcm_multicast_options){
        .group = 0xefff4c43, .port = 7667, .buffer = 2 << 20}; /* 239.255.76.67, liblcm's default */
    const char *host = url + strlen("udpm://");
    size_t length = strcspn(host, ":?");
    if (length) options->group = read_address(host, length);
    if (options->group >> 28 != 0xe) return false; /* 224.0.0.0/4 */
    if (host[length] == ':') {
        char *end;
        unsigned long port = strtoul(host + length + 1, &end, 10);
        if (end == host + length + 1 || (*end && *end != '?') || !port || port > 65535)
            return false;
        options->port = (uint16_t)port;
    }
    const char *buffer = strstr(host + length, "recv_buf_size=");
    long size = buffer ? strtol(buffer + strlen("recv_buf_size="), NULL, 10) : 0;
    if (size > 0 && size <= 1 << 30) options->buffer = (int)size;
    return true;
}

static bool read_senders(mukca_lcm_multicast_options *options, const mukca_lcm_network *network)
{
    const char *interface = network->interface, *from = network->from;
    if (interface && !(options->interface = read_address(interface, strlen(interface))))
        return false;
    char item[16];
    while (mukca_text_item(item, sizeof item, &from)) {
        uint32_t address = read_address(item, strlen(item));
        if (!address || options->n_from == MUKCA_LCM_MAX_FROM) return false;
        options->from[options->n_from++] = address;
    }
    return true;
}

static mukca_status open_network(mukca_lcm_link *link, const char *url,
                                 const mukca_lcm_network *network, mukca_error *error)
{
    mukca_lcm_multicast_options options;
    if (url && strncmp(url, "udpm://", 7) != 0)
        return mukca_fail(error, MUKCA_USAGE, "%.80s: neither udpm:// nor file://", url);
    link->lcm = create_quietly(url);
    if (!link->lcm)
        return mukca_fail(error, MUKCA_TRANSPORT,
                          "LCM cannot use %.80s: is there a multicast route? For one machine: ip "
                          "link set lo multicast on; ip route add 224.0.0.0/4 dev lo",
                          url ? url : "its default network");
    if (!read_url(&options, url ? url : "udpm://"))
        return mukca_fail(error, MUKCA_USAGE, "%.80s: expected udpm://GROUP:PORT?ttl=N", url);
    if (!read_senders(&options, network))
        return mukca_fail(error, MUKCA_USAGE,
                          "--interface and --from take addresses such as 192.168.1.5");
    return mukca_lcm_multicast_open(&link->multicast, &options, error);
}

mukca_status mukca_lcm_link_open(mukca_lcm_link *link, const mukca_lcm_network *network,
                                 mukca_lcm_packet_fn *receive, void *context, mukca_error *error)
{
    const char *url = network->url ? network->url : getenv("LCM_DEFAULT_URL");
    if (url && !*url) url = NULL;
    *link = (mukca_lcm_link){.receive = receive, .context = context};
    if (network->none) return MUKCA_OK;
    if (!url || strncmp(url, "file://", 7) != 0) return open_network(link, url, network, error);
    link->replays = true;
    return mukca_lcm_log_open(&link->log, url + strlen("file://"), error);
}

void mukca_lcm_link_close(mukca_lcm_link *link)
{
    mukca_lcm_multicast_close(link->multicast);
    if (link->lcm) lcm_destroy(link->lcm);
    mukca_lcm_log_close(&link->log);
    link->lcm = link->multicast = NULL;
}

/* ---- wait ---- */

static mukca_status replay(mukca_lcm_link *link, int other, bool *readable)
{
    mukca_lcm_packet event;
    for (int i = 0; i < BURST; i++) {
        if (!mukca_lcm_log_read(&event, &link->log)) return MUKCA_NEGATIVE;
        link->clock = event.time;
        link->receive(link->context, &event);
    }
    struct pollfd p = {.fd = other, .events = POLLIN};
    if (readable) *readable = poll(&p, 1, 0) > 0;
    return MUKCA_OK;
}

/* Deliver what had arrived before the call. */
static void receive(mukca_lcm_link *link)
{
    const int64_t now = mukca_clock_wall();
    bool later = false;
    for (mukca_lcm_queued *e; !later && (e = mukca_lcm_multicast_take(link->multicast)); free(e)) {
        later = e->packet.time >= now;
        link->receive(link->context, &e->packet);
    }
}

mukca_status mukca_lcm_link_wait(mukca_lcm_link *link, int timeout_ms, int other, bool *readable,
                                 mukca_error *error)
{
    if (readable) *readable = false;
    if (link->replays) return replay(link, other, readable);
    const int descriptor = link->multicast ? mukca_lcm_multicast_descriptor(link->multicast) : -1;
    struct pollfd p[2] = {{.fd = descriptor, .events = POLLIN}, {.fd = other, .events = POLLIN}};
    int n = poll(p, 2, timeout_ms);
    if (n < 0 && errno != EINTR)
        return mukca_fail(error, MUKCA_TRANSPORT, "waiting for LCM: %s", strerror(errno));
    if (n <= 0) return MUKCA_OK;
    if (readable && p[1].revents) *readable = true;
    if (p[0].revents) receive(link);
    return MUKCA_OK;
}

mukca_status mukca_lcm_link_publish(mukca_lcm_link *link, const char *channel, const void *data,
                                    size_t size, mukca_error *error)
{
    if (link->lcm && lcm_publish(link->lcm, channel, data, (unsigned)size))
        return mukca_fail(error, MUKCA_TRANSPORT, "LCM cannot send on %s", channel);
    return MUKCA_OK;
}

/* ---- event logs, big-endian: sync word, number, time in us, lengths of channel and data (28
 * bytes) ---- */

enum { HEADER = 28 };
const unsigned char mukca_lcm_log_sync[4] = {0xED, 0xA1, 0xDA, 0x01};

mukca_status mukca_lcm_log_open(mukca_lcm_log *log, const char *path, mukca_error *error)
{
    mukca_lcm_packet first;
    *log = (mukca_lcm_log){.file = fopen(path, "re"), .data = malloc(MUKCA_LCM_MAX_MESSAGE)};
    if (!log->file || !log->data) {
        const int reason = errno;
        mukca_lcm_log_close(log);
        return mukca_fail(error, mukca_output_status(reason), "LCM log %s: %s", path,
                          strerror(reason));
    }
    if (mukca_lcm_log_read(&first, log)) {
        rewind(log->file);
        log->skipped = 0;
        return MUKCA_OK;
    }
    mukca_lcm_log_close(log);
    return mukca_fail(error, MUKCA_INPUT, "%s: not a log of LCM messages; record it by lcm-logger",
                      path);
}

/* Read the event of a header; false: it is none, and is read again. */
static bool read_event(mukca_lcm_packet *event, mukca_lcm_log *log, const unsigned char *head)
{
    const size_t channel = (size_t)mukca_lcm_wire_get(head + 20, 4),
                 data = (size_t)mukca_lcm_wire_get(head + 24, 4);
    const int64_t time = (int64_t)mukca_lcm_wire_get(head + 12, 8);
    const int64_t longest = (int64_t)1 << 53; /* us: 285 years, that differences are exact */
    const off_t at = ftello(log->file);
    if (memcmp(head, mukca_lcm_log_sync, 4) != 0 || channel == 0 || time > longest ||
        time < -longest || channel >= sizeof log->channel || data > MUKCA_LCM_MAX_MESSAGE)
        return false;
    if (fread(log->channel, 1, channel, log->file) != channel ||
        fread(log->data, 1, data, log->file) != data) {
        (void)fseeko(log->file, at, SEEK_SET);
        return false;
    }
    log->channel[channel] = '\0';
    *event =
        (mukca_lcm_packet){.channel = log->channel, .data = log->data, .size = data, .time = time};
    return true;
}

bool mukca_lcm_log_read(mukca_lcm_packet *event, mukca_lcm_log *log)
{
    unsigned char head[HEADER];
    size_t n = 0;
    while (log->file && (n += fread(head + n, 1, HEADER - n, log->file)) == HEADER) {
        if (read_event(event, log, head)) return true;
        const unsigned char *next = memchr(head + 1, mukca_lcm_log_sync[0], HEADER - 1);
        const size_t skip = next ? (size_t)(next - head) : HEADER;
        log->skipped += (int64_t)skip;
        n -= skip;
        memmove(head, head + skip, n);
    }
    log->skipped += (int64_t)n;
    return false;
}

void mukca_lcm_log_close(mukca_lcm_log *log)
{
    if (log->file) fclose(log->file);
    free(log->data);
    log->file = NULL;
    log->data = NULL;
}
