/* An LCM network: liblcm for sending, and for receiving from networks other than UDP multicast. */
#include "lcm/receiver.h"

#include <arpa/inet.h>
#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <lcm/lcm.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "lcm/multicast.h"

struct mukca_lcm_receiver {
    lcm_t *lcm;
    mukca_lcm_multicast *multicast; /* NULL: liblcm receives */
    bool listens_to_all;
    lcm_subscription_t *all; /* liblcm's subscription to all channels */
    mukca_lcm_receive_fn *receive;
    void *context;
};

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
    while (from) {
        size_t length = strcspn(from, ",");
        uint32_t address = read_address(from, length);
        if (!address || options->n_from == MUKCA_LCM_MAX_FROM) return false;
        options->from[options->n_from++] = address;
        from = from[length] ? from + length + 1 : NULL;
    }
    return true;
}

mukca_status mukca_lcm_receiver_open(mukca_lcm_receiver **receiver,
                                     const mukca_lcm_network *network,
                                     mukca_lcm_receive_fn *receive, void *context,
                                     mukca_error *error)
{
    mukca_lcm_receiver *r = calloc(1, sizeof *r);
    const char *url = network->url;
    *receiver = NULL;
    if (!r) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    *r = (mukca_lcm_receiver){.lcm = create_quietly(url), .receive = receive, .context = context};
    mukca_status status = MUKCA_OK;
    mukca_lcm_multicast_options options;
    bool udp = !url || strncmp(url, "udpm://", 7) == 0;
    if (!r->lcm)
        status = mukca_fail(error, MUKCA_TRANSPORT,
                            "LCM cannot use %.80s: is there a multicast route? For one machine: ip "
                            "link set lo multicast on; ip route add 224.0.0.0/4 dev lo",
                            url ? url : "its default network");
    else if (udp && !read_url(&options, url ? url : "udpm://"))
        status = mukca_fail(error, MUKCA_USAGE, "%.80s: expected udpm://GROUP:PORT?ttl=N", url);
    else if (udp && !read_senders(&options, network))
        status = mukca_fail(error, MUKCA_USAGE,
                            "--interface and --from take addresses such as 192.168.1.5");
    else if (!udp && (network->interface || network->from))
        status = mukca_fail(error, MUKCA_USAGE, "--interface and --from belong to a UDP network");
    else if (udp)
        status = mukca_lcm_multicast_open(&r->multicast, &options, error);
    if (status == MUKCA_OK)
        *receiver = r;
    else
        mukca_lcm_receiver_close(r);
    return status;
}

static void deliver(const lcm_recv_buf_t *buffer, const char *channel, mukca_lcm_receiver *r,
                    bool all)
{
    mukca_lcm_packet packet = {.channel = channel,
                               .data = buffer->data,
                               .size = buffer->data_size,
                               .time = buffer->recv_utime};
    r->receive(r->context, &packet, all);
}

static void on_named(const lcm_recv_buf_t *buffer, const char *channel, void *receiver)
{
    deliver(buffer, channel, receiver, false);
}

static void on_any(const lcm_recv_buf_t *buffer, const char *channel, void *receiver)
{
    deliver(buffer, channel, receiver, true);
}

mukca_status mukca_lcm_receiver_subscribe(mukca_lcm_receiver *r, const char *channel,
                                          mukca_error *error)
{
    if (!channel) r->listens_to_all = true;
    if (r->multicast) return mukca_lcm_multicast_listen(r->multicast, channel, error);
    char pattern[2 * 64 + 1] = ".*"; /* subscriptions are regular expressions */
    size_t n = 0;
    for (const char *c = channel; c && *c && n + 2 < sizeof pattern; c++) {
        if (!isalnum((unsigned char)*c) && *c != '_' && (unsigned char)*c < 128)
            pattern[n++] = '\\';
        pattern[n++] = *c;
        pattern[n] = '\0';
    }
    lcm_subscription_t *subscription =
        lcm_subscribe(r->lcm, pattern, channel ? on_named : on_any, r);
    if (!subscription)
        return mukca_fail(error, MUKCA_TRANSPORT,
                          "LCM cannot listen to \"%s\": is multicast blocked by a firewall?",
                          channel ? channel : "all channels");
    lcm_subscription_set_queue_capacity(subscription, 0); /* by default, more than 30 are dropped */
    if (!channel) r->all = subscription;
    return MUKCA_OK;
}

void mukca_lcm_receiver_unsubscribe_all(mukca_lcm_receiver *r)
{
    r->listens_to_all = false;
    if (r->multicast) mukca_lcm_multicast_unlisten_all(r->multicast);
    if (r->all) lcm_unsubscribe(r->lcm, r->all);
    r->all = NULL;
}

int mukca_lcm_receiver_descriptor(const mukca_lcm_receiver *r)
{
    if (r->multicast) return mukca_lcm_multicast_descriptor(r->multicast);
    return lcm_get_fileno(r->lcm); /* the descriptor starts liblcm's receiver; not for UDP */
}

/* Deliver what had arrived before the call. */
static void handle_multicast(mukca_lcm_receiver *r)
{
    bool named, later = false;
    const int64_t now = mukca_clock_wall();
    for (mukca_lcm_queued *e; !later && (e = mukca_lcm_multicast_take(r->multicast, &named));) {
        later = e->packet.time >= now;
        if (named || r->listens_to_all) r->receive(r->context, &e->packet, !named);
        free(e);
    }
}

mukca_status mukca_lcm_receiver_handle(mukca_lcm_receiver *r, mukca_error *error)
{
    if (r->multicast)
        handle_multicast(r);
    else if (lcm_handle(r->lcm) < 0 && errno != EINTR)
        return mukca_fail(error, MUKCA_TRANSPORT, "LCM stopped receiving");
    return MUKCA_OK;
}

mukca_status mukca_lcm_receiver_publish(mukca_lcm_receiver *r, const mukca_lcm_packet *packet,
                                        mukca_error *error)
{
    if (lcm_publish(r->lcm, packet->channel, packet->data, (unsigned)packet->size))
        return mukca_fail(error, MUKCA_TRANSPORT, "LCM cannot send on %s", packet->channel);
    return MUKCA_OK;
}

int64_t mukca_lcm_receiver_dropped(mukca_lcm_receiver *r, char reason[128])
{
    return r->multicast ? mukca_lcm_multicast_dropped(r->multicast, reason) : 0;
}

void mukca_lcm_receiver_close(mukca_lcm_receiver *r)
{
    if (!r) return;
    mukca_lcm_multicast_close(r->multicast);
    if (r->lcm) lcm_destroy(r->lcm);
    free(r);
}
