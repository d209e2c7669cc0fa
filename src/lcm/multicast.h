/* The receiving end of an LCM network: a UDP multicast group, read by a thread of its own. */
#ifndef MUKCA_LCM_MULTICAST_H
#define MUKCA_LCM_MULTICAST_H

#include "lcm/packet.h"
#include "mukca/status.h"

enum { MUKCA_LCM_MAX_NAMED = 8, MUKCA_LCM_MAX_FROM = 16 };

/* IPv4 addresses as numbers, the first byte highest. */
typedef struct {
    uint32_t group, interface; /* interface 0: the multicast route's, and this machine's senders */
    uint16_t port;
    int buffer; /* of the socket, bytes */
    int n_from;
    uint32_t from[MUKCA_LCM_MAX_FROM]; /* senders to accept; none: see `interface` */
} mukca_lcm_multicast_options;

typedef struct mukca_lcm_multicast mukca_lcm_multicast;

/* Join the group.  Errors: MUKCA_TRANSPORT, MUKCA_MEMORY. */
mukca_status mukca_lcm_multicast_open(mukca_lcm_multicast **multicast,
                                      const mukca_lcm_multicast_options *options,
                                      mukca_error *error);

/* Receive a channel, taken literally; NULL is all channels.  Errors: MUKCA_USAGE (too many). */
mukca_status mukca_lcm_multicast_listen(mukca_lcm_multicast *m, const char *channel,
                                        mukca_error *error);
void mukca_lcm_multicast_unlisten_all(mukca_lcm_multicast *m);

/* Readable while a message waits, for poll(2). */
int mukca_lcm_multicast_descriptor(const mukca_lcm_multicast *m);

/* The oldest message, NULL: none waits; valid until it is removed.  `named`: its channel is
 * listened to by name. */
const mukca_lcm_packet *mukca_lcm_multicast_front(mukca_lcm_multicast *m, bool *named);
void mukca_lcm_multicast_pop(mukca_lcm_multicast *m);

/* Messages and datagrams dropped so far; `reason` is that of the last ones. */
int64_t mukca_lcm_multicast_dropped(mukca_lcm_multicast *m, char reason[128]);

/* NULL is harmless. */
void mukca_lcm_multicast_close(mukca_lcm_multicast *m);

#endif
