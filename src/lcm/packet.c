/* Reassembly of LCM's UDP protocol, and a bounded queue.  All sizes are checked in 64-bit
 * arithmetic before use. */
#include "lcm/packet.h"

#include <stdlib.h>
#include <string.h>

enum { /* the protocol's magic numbers and header sizes before the channel */
       SMALL = 0x4c433032,
       FRAGMENT = 0x4c433033,
       SMALL_HEADER = 8,
       FRAGMENT_HEADER = 20
};

static const int64_t expiry_us = 1000000; /* the fragments of a message are sent back to back */

static const char bad_channel[] = "channel empty, too long or without end";

static bool drop(mukca_lcm_reassembly *r, const char *why)
{
    r->dropped++;
    r->reason = why;
    return false;
}

/* Read the channel at the start of `wire` and advance past its NUL; NULL: invalid. */
static const char *read_channel(mukca_lcm_wire *wire)
{
    const char *channel = (const char *)wire->at;
    size_t limit = wire->left < MUKCA_LCM_CHANNEL_SIZE ? wire->left : MUKCA_LCM_CHANNEL_SIZE;
    const char *end = limit ? memchr(channel, '\0', limit) : NULL;
    if (!end || end == channel) return NULL;
    mukca_lcm_wire_bytes(wire, (size_t)(end - channel) + 1);
    return channel;
}

static void release(mukca_lcm_partial *p)
{
    free(p->piece);
    free(p->data);
    *p = (mukca_lcm_partial){.piece = NULL};
}

/* The message that a fragment belongs to.  Another one of its sender ends, else the one that has
 * waited longest.  NULL: out of memory. */
static mukca_lcm_partial *find_message(mukca_lcm_reassembly *r, const mukca_lcm_partial *wanted)
{
    mukca_lcm_partial *p = r->partial;
    for (int i = 0; i < MUKCA_LCM_MAX_PARTIALS && (!p->piece || p->sender != wanted->sender); i++) {
        mukca_lcm_partial *other = &r->partial[i];
        if (other->piece ? other->sender == wanted->sender ||
                               (p->piece &&
                                llabs(wanted->time - other->time) > llabs(wanted->time - p->time))
                         : p->piece != NULL)
            p = other;
    }
    if (p->piece && p->sender == wanted->sender && p->sequence == wanted->sequence &&
        p->size == wanted->size && p->n == wanted->n && llabs(wanted->time - p->time) <= expiry_us)
        return p;
    if (p->received < p->n) drop(r, "incomplete message");
    release(p);
    *p = *wanted;
    p->piece = calloc(p->n, sizeof *p->piece);
    p->data = malloc(p->size);
    if (p->piece && p->data) return p;
    release(p);
    return NULL;
}

/* Whether the fragments cover the message without gap or overlap. */
static bool is_covered(const mukca_lcm_partial *p)
{
    uint64_t end = 0;
    for (unsigned i = 0; i < p->n; i++) {
        if (p->piece[i].offset != end) return false;
        end += p->piece[i].size;
    }
    return end == p->size;
}

static bool add_fragment(mukca_lcm_packet *packet, mukca_lcm_reassembly *r)
{
    const unsigned char *head = packet->data;
    mukca_lcm_wire wire = {head + FRAGMENT_HEADER, packet->size - FRAGMENT_HEADER};
    const mukca_lcm_partial wanted = {.sender = packet->sender,
                                      .sequence = (uint32_t)mukca_lcm_wire_get(head + 4, 4),
                                      .size = (uint32_t)mukca_lcm_wire_get(head + 8, 4),
                                      .n = (unsigned)mukca_lcm_wire_get(head + 18, 2),
                                      .time = packet->time};
    const uint64_t offset = mukca_lcm_wire_get(head + 12, 4);
    const unsigned number = (unsigned)mukca_lcm_wire_get(head + 16, 2);
    const char *channel = number == 0 ? read_channel(&wire) : "";
    if (!channel) return drop(r, bad_channel);
    if (wanted.size > MUKCA_LCM_MAX_MESSAGE || offset + wire.left > wanted.size || !wire.left ||
        number >= wanted.n || wanted.n > wanted.size)
        return drop(r, "message too large, or fragment outside of it");
    mukca_lcm_partial *p = find_message(r, &wanted);
    if (!p) return drop(r, "incomplete message");
    if (p->piece[number].size) return drop(r, "fragment twice, or overlapping another");
    p->piece[number] = (mukca_lcm_piece){(uint32_t)offset, (uint32_t)wire.left};
    p->time = packet->time;
    memcpy(p->data + offset, wire.at, wire.left);
    if (number == 0) memcpy(p->channel, channel, strlen(channel) + 1);
    if (++p->received < p->n) return false;
    packet->channel = p->channel;
    packet->data = p->data;
    packet->size = p->size;
    return is_covered(p) || drop(r, "fragment twice, or overlapping another");
}

bool mukca_lcm_packet_take(mukca_lcm_packet *packet, mukca_lcm_reassembly *r)
{
    const unsigned char *head = packet->data;
    const uint64_t magic = packet->size >= SMALL_HEADER ? mukca_lcm_wire_get(head, 4) : 0;
    if (magic == FRAGMENT && packet->size >= FRAGMENT_HEADER) return add_fragment(packet, r);
    if (magic != SMALL) return drop(r, "too short, or not LCM");
    mukca_lcm_wire wire = {head + SMALL_HEADER, packet->size - SMALL_HEADER};
    packet->channel = read_channel(&wire);
    packet->data = wire.at;
    packet->size = wire.left;
    return packet->channel || drop(r, bad_channel);
}

void mukca_lcm_packet_clear(mukca_lcm_reassembly *r)
{
    for (int i = 0; i < MUKCA_LCM_MAX_PARTIALS; i++) release(&r->partial[i]);
}

/* ---- the queue ---- */

/* Remove the oldest message of a sender, NULL: of any; there is one.  It is behind those of others:
 * at most MUKCA_LCM_QUEUE_BYTES / MUKCA_LCM_QUEUE_EACH. */
static mukca_lcm_queued *remove_oldest(mukca_lcm_queue *q, const mukca_lcm_queue_sender *sender)
{
    mukca_lcm_queued **at = &q->first;
    while (sender && (*at)->sender != sender) at = &(*at)->next;
    mukca_lcm_queued *oldest = *at;
    *at = oldest->next;
    if (!oldest->next) q->end = at;
    oldest->sender->bytes -= oldest->bytes;
    q->bytes -= oldest->bytes;
    return oldest;
}

static void drop_oldest(mukca_lcm_queue *q, const mukca_lcm_queue_sender *sender)
{
    free(remove_oldest(q, sender));
    q->dropped++;
}

/* The sender with most bytes in a queue that is not empty. */
static const mukca_lcm_queue_sender *largest(const mukca_lcm_queue *q)
{
    const mukca_lcm_queue_sender *most = q->sender;
    for (int i = 1; i < MUKCA_LCM_QUEUE_SENDERS; i++)
        if (q->sender[i].bytes > most->bytes) most = &q->sender[i];
    return most;
}

bool mukca_lcm_queue_push(mukca_lcm_queue *q, const mukca_lcm_packet *packet)
{
    const size_t name = strlen(packet->channel) + 1, bytes = name + packet->size;
    mukca_lcm_queue_sender *sender = NULL;
    for (mukca_lcm_queue_sender *s = q->sender; s < q->sender + MUKCA_LCM_QUEUE_SENDERS; s++)
        if (s->bytes ? s->id == packet->sender : !sender) sender = s;
    mukca_lcm_queued *e =
        sender && packet->size <= MUKCA_LCM_MAX_MESSAGE ? malloc(sizeof *e + bytes) : NULL;
    if (!e) {
        q->dropped++;
        return false;
    }
    *e = (mukca_lcm_queued){
        .sender = sender, .bytes = bytes + MUKCA_LCM_QUEUE_EACH, .packet = *packet};
    while (sender->bytes + e->bytes > MUKCA_LCM_QUEUE_BYTES / 2) drop_oldest(q, sender);
    while (q->bytes + e->bytes > MUKCA_LCM_QUEUE_BYTES) drop_oldest(q, largest(q));
    sender->id = packet->sender;
    sender->bytes += e->bytes;
    q->bytes += e->bytes;
    e->packet.channel = memcpy(e->content, packet->channel, name);
    e->packet.data = e->content + name;
    if (packet->size) memcpy(e->content + name, packet->data, packet->size);
    *(q->first ? q->end : &q->first) = e;
    q->end = &e->next;
    return true;
}

mukca_lcm_queued *mukca_lcm_queue_take(mukca_lcm_queue *q)
{
    return q->first ? remove_oldest(q, NULL) : NULL;
}
