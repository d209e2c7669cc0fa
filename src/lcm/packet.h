/* LCM's UDP protocol, receiving side: reassembly of datagrams to messages within fixed bounds. */
#ifndef MUKCA_LCM_PACKET_H
#define MUKCA_LCM_PACKET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    MUKCA_LCM_CHANNEL_SIZE = 64,       /* LCM's limit, including the NUL */
    MUKCA_LCM_MAX_MESSAGE = 8 << 20,   /* bytes; mukca's largest is a result with JSON */
    MUKCA_LCM_MAX_PARTIALS = 32,       /* incomplete messages of all senders */
    MUKCA_LCM_SENDER_PARTIALS = 4,     /* of one sender; liblcm sends one at a time */
    MUKCA_LCM_PARTIAL_BYTES = 16 << 20 /* bytes of all incomplete messages */
};

/* A complete message. */
typedef struct {
    const char *channel;
    const void *data;
    size_t size;
    int64_t time;    /* us since 1970, time of reception (UDP: by the kernel) or logging */
    uint64_t sender; /* IPv4 address << 16 | port; 0: unknown */
} mukca_lcm_packet;

typedef struct {
    const void *data;
    size_t size;
    int64_t time; /* us; only differences are used */
    uint64_t sender;
} mukca_lcm_datagram;

/* Reasons for dropping datagrams and incomplete messages. */
#define MUKCA_LCM_DROP_LIST(X)                              \
    X(SHORT, "too short, or not LCM")                       \
    X(CHANNEL, "channel empty, too long or without end")    \
    X(SIZE, "message too large, or fragment outside of it") \
    X(FRAGMENT, "fragment contradicts the others")          \
    X(DUPLICATE, "fragment received before")                \
    X(EXPIRED, "incomplete after one second")               \
    X(EVICTED, "incomplete, pushed out by too many others")

typedef enum {
#define MUKCA_LCM_DROP_ENUM(name, text) MUKCA_LCM_DROP_##name,
    MUKCA_LCM_DROP_LIST(MUKCA_LCM_DROP_ENUM)
#undef MUKCA_LCM_DROP_ENUM
        MUKCA_LCM_DROPS
} mukca_lcm_drop;

extern const char *const mukca_lcm_drop_texts[MUKCA_LCM_DROPS];

/* Position of a fragment in its message; `size` 0: not received. */
typedef struct {
    uint32_t offset, size;
} mukca_lcm_piece;

typedef struct {
    uint64_t sender;
    uint32_t sequence, size; /* size: bytes of the complete payload */
    unsigned n, received;    /* numbers of fragments */
    int64_t time;            /* us, of the latest fragment */
    char channel[MUKCA_LCM_CHANNEL_SIZE];
    mukca_lcm_piece *piece; /* [n]; NULL: the slot is free */
    unsigned char *data;    /* [size] */
} mukca_lcm_partial;

/* Zeroed: no messages. */
typedef struct {
    mukca_lcm_partial partial[MUKCA_LCM_MAX_PARTIALS];
    size_t bytes;                         /* allocated by `partial` */
    unsigned char *whole;                 /* the last reassembled message */
    char channel[MUKCA_LCM_CHANNEL_SIZE]; /* its channel */
    int64_t dropped[MUKCA_LCM_DROPS];
} mukca_lcm_reassembly;

/* Process one datagram of any content.  True: it completes a message; `packet` points into the
 * datagram or into `r` and is valid until the next call.  Messages of one datagram need no
 * allocation.  Only bytes that were received are delivered. */
bool mukca_lcm_packet_take(mukca_lcm_packet *packet, mukca_lcm_reassembly *r,
                           const mukca_lcm_datagram *datagram);

/* Free all memory; the counts are kept. */
void mukca_lcm_packet_clear(mukca_lcm_reassembly *r);

/* ---- bounded queue of messages ----
 *
 * A sender that exceeds its share loses its oldest ones: its latest joint states are kept, and the
 * messages of others. */

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

#endif
