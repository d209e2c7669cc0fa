/* Receiver of an LCM network: a UDP multicast group, read by a separate thread. */
#ifndef MUKCA_LCM_MULTICAST_H
#define MUKCA_LCM_MULTICAST_H

#include "lcm/packet.h"
#include "mukca/status.h"

/* ---- queue.c ----
 *
 * Bounded queue of received messages.  A sender that exceeds its share loses its oldest ones: its
 * latest joint states are kept, and the messages of others. */

enum {
    MUKCA_LCM_QUEUE_BYTES = 2 * (MUKCA_LCM_MAX_MESSAGE + MUKCA_LCM_CHANNEL_SIZE),
    MUKCA_LCM_QUEUE_LENGTH = 4096,
    /* messages per sender: 1 s of joint states at 1 kHz, several windows of a sample */
    MUKCA_LCM_QUEUE_SHARE = 1024,
    MUKCA_LCM_QUEUE_SENDERS = 64
};

/* A message; channel and data are in `bytes`. */
typedef struct mukca_lcm_queued {
    struct mukca_lcm_queued *next; /* of its sender */
    uint64_t number;               /* in order of arrival */
    size_t size;                   /* of `bytes` */
    mukca_lcm_packet packet;
    unsigned char bytes[];
} mukca_lcm_queued;

typedef struct {
    mukca_lcm_queued *first, *last; /* NULL: the slot is free */
    int n;
    size_t bytes;
} mukca_lcm_queue_sender;

/* Zeroed: empty. */
typedef struct {
    mukca_lcm_queue_sender sender[MUKCA_LCM_QUEUE_SENDERS];
    int n;
    size_t bytes;
    uint64_t number;
    int64_t dropped; /* for lack of space */
} mukca_lcm_queue;

/* Copy a message to the end of the queue.  The oldest message of its sender goes if the sender's
 * share is exhausted, that of the largest sender if the queue is full.  False: the message itself
 * was dropped (too many senders, out of memory). */
bool mukca_lcm_queue_push(mukca_lcm_queue *q, const mukca_lcm_packet *packet);

/* Remove the oldest message; free it with free(3).  NULL: empty. */
mukca_lcm_queued *mukca_lcm_queue_take(mukca_lcm_queue *q);

/* ---- multicast.c ---- */

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
