/* LCM's UDP protocol, receiving side: reassembly of datagrams to messages within fixed bounds. */
#ifndef MUKCA_LCM_PACKET_H
#define MUKCA_LCM_PACKET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "mukca/status.h"

/* ---- big-endian numbers and texts of messages and event logs, with bounds checks ---- */

/* The unread rest of a message. */
typedef struct {
    const unsigned char *at;
    size_t left; /* bytes */
} mukca_lcm_wire;

/* Read, or write, an unsigned number of 1 to 8 bytes at `at`. */
static inline uint64_t mukca_lcm_wire_get(const unsigned char *at, int size)
{
    uint64_t value = 0;
    for (int i = 0; i < size; i++) value = value << 8 | at[i];
    return value;
}

static inline void mukca_lcm_wire_put(unsigned char *at, uint64_t value, int size)
{
    for (int i = 0; i < size; i++) at[i] = (unsigned char)(value >> 8 * (size - 1 - i));
}

/* Read the next n bytes; NULL: fewer are left. */
static inline const unsigned char *mukca_lcm_wire_bytes(mukca_lcm_wire *wire, size_t n)
{
    const unsigned char *at = wire->at;
    if (n > wire->left) return NULL;
    wire->at += n;
    wire->left -= n;
    return at;
}

/* Read the next text: 4 bytes of length, including the NUL, then the characters.  The result points
 * into the message; NULL: truncated, or not NUL-terminated. */
static inline const char *mukca_lcm_wire_text(mukca_lcm_wire *wire)
{
    const unsigned char *head = mukca_lcm_wire_bytes(wire, 4);
    uint64_t length = head ? mukca_lcm_wire_get(head, 4) : 0;
    const unsigned char *text = length ? mukca_lcm_wire_bytes(wire, length) : NULL;
    return text && text[length - 1] == '\0' ? (const char *)text : NULL;
}

/* ---- messages from datagrams ---- */

enum {
    MUKCA_LCM_CHANNEL_SIZE = 64,     /* LCM's limit, including the NUL */
    MUKCA_LCM_MAX_MESSAGE = 8 << 20, /* bytes; mukca's largest is a result with JSON */
    MUKCA_LCM_MAX_PARTIALS = 8       /* messages in fragments; one per sender, as liblcm sends */
};

/* A complete message; or a datagram, whose channel is not read yet. */
typedef struct {
    const char *channel;
    const void *data;
    size_t size;
    int64_t time;    /* us since 1970, time of reception (UDP: by the kernel) or logging */
    uint64_t sender; /* IPv4 address << 16 | port; 0: unknown */
} mukca_lcm_packet;

/* Position of a fragment in its message; `size` 0: not received. */
typedef struct {
    uint32_t offset, size;
} mukca_lcm_piece;

/* The last message in fragments of a sender; `received` n: complete. */
typedef struct {
    uint64_t sender;
    uint32_t sequence, size; /* size: bytes of the complete payload */
    unsigned n, received;    /* numbers of fragments */
    int64_t time;            /* us, of the latest fragment */
    char channel[MUKCA_LCM_CHANNEL_SIZE];
    mukca_lcm_piece *piece; /* [n] */
    unsigned char *data;    /* [size] */
} mukca_lcm_partial;

/* Zeroed: no messages. */
typedef struct {
    mukca_lcm_partial partial[MUKCA_LCM_MAX_PARTIALS];
    int64_t dropped;    /* datagrams and incomplete messages */
    const char *reason; /* of the last one */
} mukca_lcm_reassembly;

/* Process one datagram of any content.  True: it completes a message, which replaces it in
 * `packet`, points into the datagram or into `r`, and is valid until the next call.  Messages of
 * one datagram need no allocation.  Only bytes that were received are delivered. */
bool mukca_lcm_packet_take(mukca_lcm_packet *packet, mukca_lcm_reassembly *r);

/* Free all memory; the count is kept. */
void mukca_lcm_packet_clear(mukca_lcm_reassembly *r);

/* ---- bounded queue of messages ----
 *
 * A sender that exceeds its share, half of the queue, loses its oldest ones: its latest joint
 * states are kept, and the messages of others.  The half holds 1 s of joint states at 1 kHz. */

enum {
    MUKCA_LCM_QUEUE_EACH = 8192, /* bytes that a message counts more than its own */
    MUKCA_LCM_QUEUE_BYTES =
        2 * (MUKCA_LCM_MAX_MESSAGE + MUKCA_LCM_CHANNEL_SIZE + MUKCA_LCM_QUEUE_EACH),
    MUKCA_LCM_QUEUE_SENDERS = 64
};

typedef struct {
    uint64_t id;
    size_t bytes; /* in the queue; 0: the slot is free */
} mukca_lcm_queue_sender;

/* A message; channel and data are in `content`. */
typedef struct mukca_lcm_queued {
    struct mukca_lcm_queued *next;
    mukca_lcm_queue_sender *sender;
    size_t bytes; /* as counted */
    mukca_lcm_packet packet;
    unsigned char content[];
} mukca_lcm_queued;

/* Zeroed: empty. */
typedef struct {
    mukca_lcm_queued *first, **end; /* oldest first; end: the last one's `next`, if there is one */
    mukca_lcm_queue_sender sender[MUKCA_LCM_QUEUE_SENDERS];
    size_t bytes;
    int64_t dropped; /* for lack of space */
} mukca_lcm_queue;

/* Copy a message to the end of the queue.  The oldest message of its sender goes if the sender's
 * share is exhausted, that of the largest sender if the queue is full.  False: the message itself
 * was dropped (too many senders, out of memory). */
bool mukca_lcm_queue_push(mukca_lcm_queue *q, const mukca_lcm_packet *packet);

/* Remove the oldest message; free it with free(3).  NULL: empty. */
mukca_lcm_queued *mukca_lcm_queue_take(mukca_lcm_queue *q);

/* ---- receiver of a UDP multicast group, read by a separate thread (multicast.c) ---- */

enum { MUKCA_LCM_MAX_NAMED = 3, MUKCA_LCM_MAX_FROM = 16 };

/* IPv4 addresses in host byte order. */
typedef struct {
    uint32_t group, interface; /* interface 0: that of the multicast route, local senders only */
    uint16_t port;
    int buffer; /* of the socket's receive buffer, bytes */
    int n_from;
    uint32_t from[MUKCA_LCM_MAX_FROM]; /* accepted senders; none: see `interface` */
} mukca_lcm_multicast_options;

/* Channels to be received: all, or those of these names; "": none. */
typedef struct {
    bool all;
    char name[MUKCA_LCM_MAX_NAMED][MUKCA_LCM_CHANNEL_SIZE];
} mukca_lcm_channels;

typedef struct mukca_lcm_multicast mukca_lcm_multicast;

/* Join the group.  Errors: MUKCA_TRANSPORT, MUKCA_MEMORY. */
mukca_status mukca_lcm_multicast_open(mukca_lcm_multicast **multicast,
                                      const mukca_lcm_multicast_options *options,
                                      mukca_error *error);

/* Receive these channels from now on.  m NULL: nothing is received. */
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
