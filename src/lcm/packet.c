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

#define DROP_TEXT(name, text) text,
const char *const mukca_lcm_drop_texts[MUKCA_LCM_DROPS] = {MUKCA_LCM_DROP_LIST(DROP_TEXT)};

static bool drop(mukca_lcm_reassembly *r, mukca_lcm_drop why)
{
    r->dropped[why]++;
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

static size_t cost(const mukca_lcm_partial *p)
{
    return p->size + p->n * sizeof *p->piece;
}

/* Free a partial message; with `keep`, not its data. */
static void release(mukca_lcm_reassembly *r, mukca_lcm_partial *p, bool keep)
{
    r->bytes -= cost(p);
    free(p->piece);
    if (!keep) free(p->data);
    *p = (mukca_lcm_partial){.piece = NULL};
}

/* Drop partial messages that are too old, or later than now: the clock was set back. */
static void expire(mukca_lcm_reassembly *r, int64_t now)
{
    for (mukca_lcm_partial *p = r->partial; p < r->partial + MUKCA_LCM_MAX_PARTIALS; p++) {
        if (!p->piece || (now >= p->time && now - p->time <= expiry_us)) continue;
        drop(r, MUKCA_LCM_DROP_EXPIRED);
        release(r, p, false);
    }
}

/* Drop the oldest partial message of `sender` (0: of any sender). */
static void evict(mukca_lcm_reassembly *r, uint64_t sender)
{
    mukca_lcm_partial *oldest = NULL;
    for (mukca_lcm_partial *p = r->partial; p < r->partial + MUKCA_LCM_MAX_PARTIALS; p++)
        if (p->piece && (!sender || p->sender == sender) && (!oldest || p->time < oldest->time))
            oldest = p;
    if (!oldest) return;
    drop(r, MUKCA_LCM_DROP_EVICTED);
    release(r, oldest, false);
}

static mukca_lcm_partial *find_free(mukca_lcm_reassembly *r)
{
    for (int i = 0; i < MUKCA_LCM_MAX_PARTIALS; i++)
        if (!r->partial[i].piece) return &r->partial[i];
    return NULL;
}

/* Allocate a slot for a new message; NULL: out of memory. */
static mukca_lcm_partial *begin(mukca_lcm_reassembly *r, const mukca_lcm_partial *wanted)
{
    int own = 0;
    size_t own_bytes = 0;
    for (int i = 0; i < MUKCA_LCM_MAX_PARTIALS; i++) {
        const mukca_lcm_partial *p = &r->partial[i];
        if (!p->piece || p->sender != wanted->sender) continue;
        own++;
        own_bytes += cost(p);
    }
    /* a sender evicts its own messages before those of others */
    if (own >= MUKCA_LCM_SENDER_PARTIALS ||
        (own && own_bytes + cost(wanted) > MUKCA_LCM_PARTIAL_BYTES / 2))
        evict(r, wanted->sender);
    while (r->bytes && r->bytes + cost(wanted) > MUKCA_LCM_PARTIAL_BYTES) evict(r, 0);
    mukca_lcm_partial *slot = find_free(r);
    if (!slot) {
        evict(r, 0);
        slot = find_free(r);
    }
    mukca_lcm_piece *piece = calloc(wanted->n, sizeof *piece);
    unsigned char *data = malloc(wanted->size);
    if (!slot || !piece || !data) {
        free(piece);
        free(data);
        return NULL;
    }
    *slot = *wanted;
    slot->piece = piece;
    slot->data = data;
    r->bytes += cost(slot);
    return slot;
}

/* Whether the fragments cover the message without gap or overlap. */
static bool complete(const mukca_lcm_partial *p)
{
    uint64_t end = 0;
    for (unsigned i = 0; i < p->n; i++) {
        if (p->piece[i].offset != end) return false;
        end += p->piece[i].size;
    }
    return end == p->size;
}

static bool add_fragment(mukca_lcm_packet *packet, mukca_lcm_reassembly *r,
                         const mukca_lcm_datagram *datagram)
{
    const unsigned char *head = datagram->data;
    mukca_lcm_wire wire = {head + FRAGMENT_HEADER, datagram->size - FRAGMENT_HEADER};
    mukca_lcm_partial header = {.sender = datagram->sender,
                                .sequence = (uint32_t)mukca_lcm_wire_get(head + 4, 4),
                                .size = (uint32_t)mukca_lcm_wire_get(head + 8, 4),
                                .n = (unsigned)mukca_lcm_wire_get(head + 18, 2),
                                .time = datagram->time};
    uint64_t offset = mukca_lcm_wire_get(head + 12, 4);
    unsigned number = (unsigned)mukca_lcm_wire_get(head + 16, 2);
    const char *channel = number == 0 ? read_channel(&wire) : "";
    if (!channel) return drop(r, MUKCA_LCM_DROP_CHANNEL);
    if (header.size > MUKCA_LCM_MAX_MESSAGE || offset + wire.left > header.size || !wire.left)
        return drop(r, MUKCA_LCM_DROP_SIZE);
    if (number >= header.n || header.n > header.size) return drop(r, MUKCA_LCM_DROP_FRAGMENT);
    mukca_lcm_partial *p = NULL;
    for (int i = 0; i < MUKCA_LCM_MAX_PARTIALS && !p; i++)
        if (r->partial[i].piece && r->partial[i].sender == header.sender &&
            r->partial[i].sequence == header.sequence)
            p = &r->partial[i];
    if (p && (p->size != header.size || p->n != header.n)) {
        release(r, p, false);
        return drop(r, MUKCA_LCM_DROP_FRAGMENT);
    }
    if (!p) p = begin(r, &header);
    if (!p) return drop(r, MUKCA_LCM_DROP_EVICTED);
    if (p->piece[number].size) return drop(r, MUKCA_LCM_DROP_DUPLICATE);
    p->piece[number] = (mukca_lcm_piece){(uint32_t)offset, (uint32_t)wire.left};
    p->time = datagram->time;
    memcpy(p->data + offset, wire.at, wire.left);
    if (number == 0) memcpy(p->channel, channel, strlen(channel) + 1);
    if (++p->received < p->n) return false;
    bool good = complete(p);
    if (good) {
        memcpy(r->channel, p->channel, sizeof r->channel);
        r->whole = p->data;
        *packet = (mukca_lcm_packet){.channel = r->channel, .data = p->data, .size = p->size};
    }
    release(r, p, good);
    return good ? true : drop(r, MUKCA_LCM_DROP_FRAGMENT);
}

bool mukca_lcm_packet_take(mukca_lcm_packet *packet, mukca_lcm_reassembly *r,
                           const mukca_lcm_datagram *datagram)
{
    free(r->whole);
    r->whole = NULL;
    if (r->bytes) expire(r, datagram->time);
    const unsigned char *head = datagram->data;
    uint64_t magic = datagram->size >= SMALL_HEADER ? mukca_lcm_wire_get(head, 4) : 0;
    if (magic == SMALL) {
        mukca_lcm_wire wire = {head + SMALL_HEADER, datagram->size - SMALL_HEADER};
        const char *channel = read_channel(&wire);
        if (!channel) return drop(r, MUKCA_LCM_DROP_CHANNEL);
        *packet = (mukca_lcm_packet){.channel = channel, .data = wire.at, .size = wire.left};
    } else if (magic == FRAGMENT && datagram->size >= FRAGMENT_HEADER) {
        if (!add_fragment(packet, r, datagram)) return false;
    } else {
        return drop(r, MUKCA_LCM_DROP_SHORT);
    }
    packet->time = datagram->time;
    packet->sender = datagram->sender;
    return true;
}

void mukca_lcm_packet_clear(mukca_lcm_reassembly *r)
{
    for (mukca_lcm_partial *p = r->partial; p < r->partial + MUKCA_LCM_MAX_PARTIALS; p++)
        if (p->piece) release(r, p, false);
    free(r->whole);
    r->whole = NULL;
}

/* ---- one list per sender; messages are numbered, so that all lists together are one queue ---- */

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
