/* Receiver of an LCM network: a UDP multicast group, read by a separate thread. */
#ifndef MUKCA_LCM_MULTICAST_H
#define MUKCA_LCM_MULTICAST_H

#include "lcm/packet.h"
#include "mukca/status.h"

enum { MUKCA_LCM_MAX_NAMED = 8, MUKCA_LCM_MAX_FROM = 16 };

/* IPv4 addresses in host byte order. */
typedef struct {
    uint32_t group, interface; /* interface 0: that of the multicast route, local senders only */
    uint16_t port;
    int buffer; /* of the socket's receive buffer, bytes */
    int n_from;
    uint32_t from[MUKCA_LCM_MAX_FROM]; /* accepted senders; none: see `interface` */
} mukca_lcm_multicast_options;

/* Channels that are subscribed: all, or n by name. */
typedef struct {
    bool all;
    int n;
    char name[MUKCA_LCM_MAX_NAMED][MUKCA_LCM_CHANNEL_SIZE];
} mukca_lcm_channels;

/* Whether a channel is among the named ones. */
bool mukca_lcm_channels_name(const mukca_lcm_channels *channels, const char *channel);

typedef struct mukca_lcm_multicast mukca_lcm_multicast;

/* Join the group.  Errors: MUKCA_TRANSPORT, MUKCA_MEMORY. */
mukca_status mukca_lcm_multicast_open(mukca_lcm_multicast **multicast,
                                      const mukca_lcm_multicast_options *options,
                                      mukca_error *error);

/* Receive these channels from now on. */
void mukca_lcm_multicast_listen(mukca_lcm_multicast *m, const mukca_lcm_channels *channels);

/* Descriptor for poll(2), readable while a message waits. */
int mukca_lcm_multicast_descriptor(const mukca_lcm_multicast *m);

/* Remove the oldest message; free it with free(3).  NULL: none. */
mukca_lcm_queued *mukca_lcm_multicast_take(mukca_lcm_multicast *m);

/* Number of messages and datagrams dropped so far; `reason` is that of the last ones. */
int64_t mukca_lcm_multicast_dropped(mukca_lcm_multicast *m, char reason[128]);

/* NULL is harmless. */
void mukca_lcm_multicast_close(mukca_lcm_multicast *m);

#endif
