/* An LCM network by liblcm. */
#include "lcm/receiver.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <lcm/lcm.h>
#include <stdlib.h>
#include <unistd.h>

struct mukca_lcm_receiver {
    lcm_t *lcm;
    lcm_subscription_t *all; /* NULL: only channels by name */
    mukca_lcm_receive_fn *receive;
    void *context;
};

/* lcm_create without its screenful about a missing route. */
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

mukca_status mukca_lcm_receiver_open(mukca_lcm_receiver **receiver, const char *url,
                                     mukca_lcm_receive_fn *receive, void *context,
                                     mukca_error *error)
{
    mukca_lcm_receiver *r = calloc(1, sizeof *r);
    *receiver = NULL;
    if (!r) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    *r = (mukca_lcm_receiver){.lcm = create_quietly(url), .receive = receive, .context = context};
    if (r->lcm) {
        *receiver = r;
        return MUKCA_OK;
    }
    free(r);
    return mukca_fail(error, MUKCA_TRANSPORT,
                      "LCM cannot use %.80s: is there a multicast route? For one machine: ip link "
                      "set lo multicast on; ip route add 224.0.0.0/4 dev lo",
                      url ? url : "its default network");
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
    lcm_subscription_set_queue_capacity(subscription, 0); /* else it drops beyond 30 */
    if (!channel) r->all = subscription;
    return MUKCA_OK;
}

void mukca_lcm_receiver_unsubscribe_all(mukca_lcm_receiver *r)
{
    if (r->all) lcm_unsubscribe(r->lcm, r->all);
    r->all = NULL;
}

int mukca_lcm_receiver_descriptor(const mukca_lcm_receiver *r)
{
    return lcm_get_fileno(r->lcm);
}

mukca_status mukca_lcm_receiver_handle(mukca_lcm_receiver *r, mukca_error *error)
{
    if (lcm_handle(r->lcm) < 0 && errno != EINTR)
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

void mukca_lcm_receiver_close(mukca_lcm_receiver *r)
{
    if (r) lcm_destroy(r->lcm);
    free(r);
}
