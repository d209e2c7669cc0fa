/* One list per sender; messages are numbered, so that all lists together are one queue. */
#include "lcm/multicast.h"

#include <stdlib.h>
#include <string.h>

/* Slot of the sender, or a free one; NULL: too many senders. */
static mukca_lcm_queue_sender *find_sender(mukca_lcm_queue *q, uint64_t id)
{
    mukca_lcm_queue_sender *slot = NULL;
    for (int i = 0; i < MUKCA_LCM_QUEUE_SENDERS; i++) {
        mukca_lcm_queue_sender *s = &q->sender[i];
        if (!s->first)
            slot = s;
        else if (s->first->packet.sender == id)
            return s;
    }
    return slot;
}

static mukca_lcm_queued *remove_first(mukca_lcm_queue *q, mukca_lcm_queue_sender *s)
{
    mukca_lcm_queued *oldest = s->first;
    s->first = oldest->next;
    s->n--;
    s->bytes -= oldest->size;
    q->n--;
    q->bytes -= oldest->size;
    return oldest;
}

static void drop_first(mukca_lcm_queue *q, mukca_lcm_queue_sender *s)
{
    free(remove_first(q, s));
    q->dropped++;
}

/* The sender with most messages, or with most bytes. */
static mukca_lcm_queue_sender *largest(mukca_lcm_queue *q, bool by_bytes)
{
    mukca_lcm_queue_sender *most = q->sender;
    for (mukca_lcm_queue_sender *s = q->sender; s < q->sender + MUKCA_LCM_QUEUE_SENDERS; s++)
        if (by_bytes ? s->bytes > most->bytes : s->n > most->n) most = s;
    return most;
}

bool mukca_lcm_queue_push(mukca_lcm_queue *q, const mukca_lcm_packet *packet)
{
    const size_t name = strlen(packet->channel) + 1, size = packet->size + name;
    mukca_lcm_queue_sender *s = find_sender(q, packet->sender);
    mukca_lcm_queued *e = s && size <= MUKCA_LCM_QUEUE_BYTES / 2 ? malloc(sizeof *e + size) : NULL;
    if (!e) {
        q->dropped++;
        return false;
    }
    while (s->n >= MUKCA_LCM_QUEUE_SHARE || s->bytes + size > MUKCA_LCM_QUEUE_BYTES / 2)
        drop_first(q, s);
    while (q->n >= MUKCA_LCM_QUEUE_LENGTH) drop_first(q, largest(q, false));
    while (q->bytes + size > MUKCA_LCM_QUEUE_BYTES) drop_first(q, largest(q, true));
    *e = (mukca_lcm_queued){.number = q->number++, .size = size, .packet = *packet};
    e->packet.channel = memcpy(e->bytes, packet->channel, name);
    e->packet.data = e->bytes + name;
    if (packet->size) memcpy(e->bytes + name, packet->data, packet->size);
    if (s->first)
        s->last->next = e;
    else
        s->first = e;
    s->last = e;
    s->n++;
    s->bytes += size;
    q->n++;
    q->bytes += size;
    return true;
}

mukca_lcm_queued *mukca_lcm_queue_take(mukca_lcm_queue *q)
{
    mukca_lcm_queue_sender *oldest = NULL;
    for (mukca_lcm_queue_sender *s = q->sender; s < q->sender + MUKCA_LCM_QUEUE_SENDERS; s++)
        if (s->first && (!oldest || s->first->number < oldest->first->number)) oldest = s;
    return oldest ? remove_first(q, oldest) : NULL;
}
