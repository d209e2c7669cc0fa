/* An LCM network (udpm://, memq://): the only file that knows liblcm. */
#ifndef MUKCA_LCM_RECEIVER_H
#define MUKCA_LCM_RECEIVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "mukca/status.h"

typedef struct mukca_lcm_receiver mukca_lcm_receiver;

typedef struct {
    const char *channel;
    const void *data;
    size_t size;
    int64_t time; /* us since 1970: when it was received or logged */
} mukca_lcm_packet;

/* `all`: delivered by the subscription to all channels, not by that to its name. */
typedef void mukca_lcm_receive_fn(void *context, const mukca_lcm_packet *packet, bool all);

/* Connect to `url` (NULL: LCM's default).  Errors: MUKCA_TRANSPORT (no multicast route: what to
 * do), MUKCA_MEMORY. */
mukca_status mukca_lcm_receiver_open(mukca_lcm_receiver **receiver, const char *url,
                                     mukca_lcm_receive_fn *receive, void *context,
                                     mukca_error *error);

/* Receive a channel, taken literally; NULL is all channels.  The first call on a network may take
 * 10 s (LCM tests itself).  Errors: MUKCA_TRANSPORT. */
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

/* NULL is harmless. */
void mukca_lcm_receiver_close(mukca_lcm_receiver *receiver);

#endif
