/* Queue of received messages: first in, first out, in fixed memory. */
#ifndef MUKCA_LCM_QUEUE_H
#define MUKCA_LCM_QUEUE_H

#include "lcm/packet.h"

enum {
    MUKCA_LCM_QUEUE_BYTES = 2 * (MUKCA_LCM_MAX_MESSAGE + MUKCA_LCM_CHANNEL_SIZE),
    MUKCA_LCM_QUEUE_LENGTH = 4096,
    /* messages per sender; a flood leaves room for others: 1 s of joint states at 1 kHz, the
     * longest disk wait to be expected */
    MUKCA_LCM_QUEUE_SHARE = 1024,
    MUKCA_LCM_QUEUE_SENDERS = 64
};

typedef struct {
    size_t start, used; /* in `bytes` */
    mukca_lcm_packet packet;
    int sender; /* index of its sender */
} mukca_lcm_queued;

/* Zeroed except `bytes`[MUKCA_LCM_QUEUE_BYTES]: empty. */
typedef struct {
    unsigned char *bytes;
    int first, n; /* of the ring `entry` */
    size_t end;   /* end of the newest message in `bytes` */
    mukca_lcm_queued entry[MUKCA_LCM_QUEUE_LENGTH];
    struct {
        uint64_t id;
        int n;        /* its messages in the queue; 0: the slot is free */
        size_t bytes; /* bytes of its messages */
    } sender[MUKCA_LCM_QUEUE_SENDERS];
    int64_t dropped; /* for lack of space */
} mukca_lcm_queue;

/* Copy a message to the end of the queue; false: no space, counted as dropped. */
bool mukca_lcm_queue_push(mukca_lcm_queue *q, const mukca_lcm_packet *packet);

/* The oldest message, valid until it is removed; NULL: empty. */
const mukca_lcm_packet *mukca_lcm_queue_front(const mukca_lcm_queue *q);

/* Remove the oldest message; the queue must not be empty. */
void mukca_lcm_queue_pop(mukca_lcm_queue *q);

#endif
