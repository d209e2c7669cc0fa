/* An LCM network.  UDP multicast is sent by liblcm and received by mukca's own code, as liblcm
 * trusts its input; other networks (memq://) use liblcm both ways.  The only file that uses
 * liblcm. */
#ifndef MUKCA_LCM_RECEIVER_H
#define MUKCA_LCM_RECEIVER_H

#include "lcm/packet.h"
#include "mukca/status.h"

typedef struct mukca_lcm_receiver mukca_lcm_receiver;

/* All may be NULL.  interface: address of the receiving interface; NULL: that of the multicast
 * route, local senders only.  from: comma-separated addresses of accepted senders, instead. */
typedef struct {
    const char *url, *interface, *from;
} mukca_lcm_network;

/* `all`: delivered by the subscription to all channels.  Over UDP a message is delivered once,
 * elsewhere once per matching subscription, by name and to all. */
typedef void mukca_lcm_receive_fn(void *context, const mukca_lcm_packet *packet, bool all);

/* Connect to network->url (NULL: LCM's default).  Errors: MUKCA_TRANSPORT (no multicast route, with
 * the remedy), MUKCA_USAGE (URL, an address), MUKCA_MEMORY. */
mukca_status mukca_lcm_receiver_open(mukca_lcm_receiver **receiver,
                                     const mukca_lcm_network *network,
                                     mukca_lcm_receive_fn *receive, void *context,
                                     mukca_error *error);

/* Subscribe to a channel by its literal name; NULL: all channels.  Errors: MUKCA_TRANSPORT,
 * MUKCA_USAGE (too many channels). */
mukca_status mukca_lcm_receiver_subscribe(mukca_lcm_receiver *receiver, const char *channel,
                                          mukca_error *error);

/* End the subscription to all channels; named channels stay subscribed. */
void mukca_lcm_receiver_unsubscribe_all(mukca_lcm_receiver *receiver);

/* Descriptor for poll(2), readable while a message waits. */
int mukca_lcm_receiver_descriptor(const mukca_lcm_receiver *receiver);

/* Deliver the messages that have arrived.  Errors: MUKCA_TRANSPORT. */
mukca_status mukca_lcm_receiver_handle(mukca_lcm_receiver *receiver, mukca_error *error);

/* Send a message.  Errors: MUKCA_TRANSPORT. */
mukca_status mukca_lcm_receiver_publish(mukca_lcm_receiver *receiver,
                                        const mukca_lcm_packet *packet, mukca_error *error);

/* Number of messages and datagrams dropped so far; if it has grown, `reason` is set. */
int64_t mukca_lcm_receiver_dropped(mukca_lcm_receiver *receiver, char reason[128]);

/* NULL is harmless. */
void mukca_lcm_receiver_close(mukca_lcm_receiver *receiver);

#endif
