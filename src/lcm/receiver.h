/* An LCM network: UDP multicast is sent by liblcm and received by code of our own, as liblcm trusts
 * what it receives; other networks (memq://) are liblcm's both ways.  The only file that knows it.
 */
#ifndef MUKCA_LCM_RECEIVER_H
#define MUKCA_LCM_RECEIVER_H

#include "lcm/packet.h"
#include "mukca/status.h"

typedef struct mukca_lcm_receiver mukca_lcm_receiver;

/* Any may be NULL.  interface: address of the interface to receive from; NULL: the one of the
 * multicast route, and from senders of this machine only.  from: addresses to receive from, commas
 * between, instead. */
typedef struct {
    const char *url, *interface, *from;
} mukca_lcm_network;

/* `all`: not delivered for its name.  Over UDP a message comes once, elsewhere once for its name
 * and once for all channels. */
typedef void mukca_lcm_receive_fn(void *context, const mukca_lcm_packet *packet, bool all);

/* Connect to network->url (NULL: LCM's default).  Errors: MUKCA_TRANSPORT (no multicast route: what
 * to do), MUKCA_USAGE (URL, an address), MUKCA_MEMORY. */
mukca_status mukca_lcm_receiver_open(mukca_lcm_receiver **receiver,
                                     const mukca_lcm_network *network,
                                     mukca_lcm_receive_fn *receive, void *context,
                                     mukca_error *error);

/* Receive a channel, taken literally; NULL is all channels.  Errors: MUKCA_TRANSPORT, MUKCA_USAGE
 * (too many channels). */
mukca_status mukca_lcm_receiver_subscribe(mukca_lcm_receiver *receiver, const char *channel,
                                          mukca_error *error);

/* End the subscription to all channels; those by name stay. */
void mukca_lcm_receiver_unsubscribe_all(mukca_lcm_receiver *receiver);

/* Readable while a message waits, for poll(2). */
int mukca_lcm_receiver_descriptor(const mukca_lcm_receiver *receiver);

/* Deliver one message.  Errors: MUKCA_TRANSPORT. */
mukca_status mukca_lcm_receiver_handle(mukca_lcm_receiver *receiver, mukca_error *error);

/* Send.  Errors: MUKCA_TRANSPORT. */
mukca_status mukca_lcm_receiver_publish(mukca_lcm_receiver *receiver,
                                        const mukca_lcm_packet *packet, mukca_error *error);

/* Messages and datagrams that were dropped so far; where that grew, `reason` says why. */
int64_t mukca_lcm_receiver_dropped(mukca_lcm_receiver *receiver, char reason[128]);

/* NULL is harmless. */
void mukca_lcm_receiver_close(mukca_lcm_receiver *receiver);

#endif
