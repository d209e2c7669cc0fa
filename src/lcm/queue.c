/* Ring of messages with their bytes in a second ring, each contiguous. */
#include "lcm/queue.h"

#include <string.h>

/* Start of a free contiguous range of `size` bytes; MUKCA_LCM_QUEUE_BYTES: none. */
static size_t find_room(const mukca_lcm_queue *q, size_t size)
{
    if (q->n == 0) return 0;
    size_t begin = q->entry[q->first].start;
    if (q->end <= begin) return size <= begin - q->end ? q->end : MUKCA_LCM_QUEUE_BYTES;
    if (size <= MUKCA_LCM_QUEUE_BYTES - q->end) return q->end;
    return size <= begin ? 0 : MUKCA_LCM_QUEUE_BYTES;
}

/* Slot of the sender; -1: its share is exhausted, or there are too many senders. */
static int find_sender(const mukca_lcm_queue *q, uint64_t id, size_t size)
{
    int slot = -1;
    for (int i = 0; i < MUKCA_LCM_QUEUE_SENDERS; i++) {
        if (q->sender[i].n && q->sender[i].id == id) {
            bool full = q->sender[i].n >= MUKCA_LCM_QUEUE_SHARE ||
                        q->sender[i].bytes + size > MUKCA_LCM_QUEUE_BYTES / 2;
            return full ? -1 : i;
        }
        if (!q->sender[i].n) slot = i;
    }
    return slot;
}

bool mukca_lcm_queue_push(mukca_lcm_queue *q, const mukca_lcm_packet *packet)
{
    size_t name = strlen(packet->channel) + 1, size = packet->size + name;
    bool fits = q->n < MUKCA_LCM_QUEUE_LENGTH && size <= MUKCA_LCM_QUEUE_BYTES;
    int sender = fits ? find_sender(q, packet->sender, size) : -1;
    size_t start = sender >= 0 ? find_room(q, size) : MUKCA_LCM_QUEUE_BYTES;
    if (start == MUKCA_LCM_QUEUE_BYTES) {
        q->dropped++;
        return false;
    }
    mukca_lcm_queued *e = &q->entry[(q->first + q->n++) % MUKCA_LCM_QUEUE_LENGTH];
    *e = (mukca_lcm_queued){.start = start, .used = size, .packet = *packet, .sender = sender};
    e->packet.channel = memcpy(q->bytes + start, packet->channel, name);
    e->packet.data = q->bytes + start + name;
    if (packet->size) memcpy(q->bytes + start + name, packet->data, packet->size);
    q->end = start + size;
    q->sender[sender].id = packet->sender;
    q->sender[sender].n++;
    q->sender[sender].bytes += size;
    return true;
}

const mukca_lcm_packet *mukca_lcm_queue_front(const mukca_lcm_queue *q)
{
    return q->n ? &q->entry[q->first].packet : NULL;
}

void mukca_lcm_queue_pop(mukca_lcm_queue *q)
{
    const mukca_lcm_queued *e = &q->entry[q->first];
    q->sender[e->sender].n--;
    q->sender[e->sender].bytes -= e->used;
    q->first = (q->first + 1) % MUKCA_LCM_QUEUE_LENGTH;
    if (--q->n == 0) q->first = 0; /* restart at 0: low traffic touches little memory */
}
