/* Received messages that wait for delivery: first in, first out, in fixed memory. */
#ifndef MUKCA_LCM_QUEUE_H
#define MUKCA_LCM_QUEUE_H

#include "lcm/packet.h"

enum {
    MUKCA_LCM_QUEUE_BYTES = 2 * (MUKCA_LCM_MAX_MESSAGE + MUKCA_LCM_CHANNEL_SIZE),
    MUKCA_LCM_QUEUE_LENGTH = 4096,
    /* of one sender, so that a flood leaves room for others: 1 s of joint states at 1 kHz, the
     * longest wait for a disk to be expected */
    MUKCA_LCM_QUEUE_SHARE = 1024,
    MUKCA_LCM_QUEUE_SENDERS = 64
};

typedef struct {
    size_t start, used; /* into `bytes` */
    mukca_lcm_packet packet;
    int sender; /* index */
} mukca_lcm_queued;

/* Zeroed but for `bytes`[MUKCA_LCM_QUEUE_BYTES]: empty. */
typedef struct {
    unsigned char *bytes;
    int first, n; /* of `entry`, which is a ring */
    size_t end;   /* of the newest message in `bytes` */
    mukca_lcm_queued entry[MUKCA_LCM_QUEUE_LENGTH];
    struct {
        uint64_t id;
        int n;        /* messages that wait; 0: the slot is free */
        size_t bytes; /* of them */
    } sender[MUKCA_LCM_QUEUE_SENDERS];
    int64_t dropped; /* for want of room */
} mukca_lcm_queue;

/* Copy a message to the end; false, and counted, where there is no room. */
bool mukca_lcm_queue_push(mukca_lcm_queue *q, const mukca_lcm_packet *packet);

/* The oldest message, valid until it is removed; NULL: empty. */
const mukca_lcm_packet *mukca_lcm_queue_front(const mukca_lcm_queue *q);

/* Remove the oldest message; there is one. */
void mukca_lcm_queue_pop(mukca_lcm_queue *q);

#endif
