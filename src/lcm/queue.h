/* Bounded queue of received messages.  A sender that exceeds its share loses its oldest ones: its
 * latest joint states are kept, and the messages of others. */
#ifndef MUKCA_LCM_QUEUE_H
#define MUKCA_LCM_QUEUE_H

#include "lcm/packet.h"

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
