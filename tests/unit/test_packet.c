/* LCM's UDP protocol: messages as liblcm sends them come whole, hostile datagrams cost nothing; the
 * queue behind it keeps its bounds. */
#include <malloc.h>

#include "close.h"
#include "lcm/packet.h"
#include "math/random.h"

enum { LARGE = 200000, PAYLOAD = 65487 /* liblcm's, of one fragment */, MAX_DATAGRAM = 65535 };

typedef struct {
    unsigned char bytes[MAX_DATAGRAM];
    size_t size;
} datagram;

/* What a fragment's header says, and how many bytes follow it. */
typedef struct {
    uint32_t sequence, size, offset;
    unsigned number, n;
    size_t bytes;
} fragment;

static unsigned char message[LARGE];

static datagram *small_datagram(const char *channel, size_t channel_size, size_t size)
{
    static datagram d;
    mukca_lcm_wire_put(d.bytes, 0x4c433032, 4);
    mukca_lcm_wire_put(d.bytes + 4, 1, 4);
    memcpy(d.bytes + 8, channel, channel_size);
    memcpy(d.bytes + 8 + channel_size, message, size);
    d.size = 8 + channel_size + size;
    return &d;
}

/* A fragment with bytes of `message` from its offset on, as far as they are inside. */
static datagram *make_fragment(const char *channel, const fragment *f)
{
    static datagram d;
    size_t name = f->number == 0 ? strlen(channel) + 1 : 0;
    mukca_lcm_wire_put(d.bytes, 0x4c433033, 4);
    mukca_lcm_wire_put(d.bytes + 4, f->sequence, 4);
    mukca_lcm_wire_put(d.bytes + 8, f->size, 4);
    mukca_lcm_wire_put(d.bytes + 12, f->offset, 4);
    mukca_lcm_wire_put(d.bytes + 16, f->number, 2);
    mukca_lcm_wire_put(d.bytes + 18, f->n, 2);
    memcpy(d.bytes + 20, channel, name);
    if ((uint64_t)f->offset + f->bytes <= LARGE)
        memcpy(d.bytes + 20 + name, message + f->offset, f->bytes);
    d.size = 20 + name + f->bytes;
    return &d;
}

/* Fragment `number` of a message of LARGE bytes, as liblcm cuts it. */
static datagram *cut(uint32_t sequence, unsigned number)
{
    const char *channel = "LARGE";
    size_t first = PAYLOAD - sizeof "LARGE";
    uint32_t offset = number ? (uint32_t)(first + (number - 1) * PAYLOAD) : 0;
    size_t bytes = number ? PAYLOAD : first;
    if (offset + bytes > LARGE) bytes = LARGE - offset;
    return make_fragment(channel, &(fragment){sequence, LARGE, offset, number, 4, bytes});
}

static mukca_lcm_reassembly r;
static mukca_lcm_packet p; /* the last one */

FIXTURE(reset)
{
    mukca_lcm_packet_clear(&r);
    r = (mukca_lcm_reassembly){.dropped = 0};
    for (size_t i = 0; i < LARGE; i++) message[i] = (unsigned char)(i * 7 + i / 256);
    return 0;
}

static bool take(const datagram *d, uint64_t sender, int64_t time)
{
    static unsigned char *kept;
    free(kept);
    kept = copied(d->bytes, d->size);
    p = (mukca_lcm_packet){.data = kept, .size = d->size, .sender = sender, .time = time};
    return mukca_lcm_packet_take(&p, &r);
}

TEST(small_messages)
{
    assert_true(take(small_datagram("ARM", 4, 500), 7, 42));
    assert_string_equal(p.channel, "ARM");
    assert_int_equal(p.size, 500);
    assert_memory_equal(p.data, message, 500);
    assert_int_equal(p.sender, 7);
    assert_int_equal(p.time, 42);
    assert_true(take(small_datagram("EMPTY", 6, 0), 7, 42));
    assert_int_equal(p.size, 0);
}

TEST(bad_headers_are_counted)
{
    char name[100];
    memset(name, 'x', sizeof name);
    assert_false(take(small_datagram("ARM", 3, 0), 7, 0)); /* no NUL */
    assert_false(take(small_datagram("", 1, 20), 7, 0));
    assert_false(take(small_datagram(name, 80, 20), 7, 0));
    assert_false(take(small_datagram("", 0, 0), 7, 0));
    assert_int_equal(r.dropped, 4);
    assert_part(r.reason, "channel");
    for (size_t size = 0; size < 8; size++) {
        datagram *d = small_datagram("ARM", 4, 0);
        d->size = size;
        assert_false(take(d, 7, 0));
    }
    for (size_t size = 8; size < 20; size++) {
        datagram *d = cut(1, 0);
        d->size = size;
        assert_false(take(d, 7, 0));
    }
    assert_int_equal(r.dropped, 24);
    assert_part(r.reason, "too short");
}

TEST(fragments_in_any_order)
{
    static const unsigned orders[][4] = {{0, 1, 2, 3}, {3, 2, 1, 0}, {2, 0, 3, 1}};
    for (size_t k = 0; k < 3; k++) {
        for (int i = 0; i < 4; i++) {
            bool last = i == 3;
            assert_int_equal(take(cut((uint32_t)k, orders[k][i]), 7, 0), last);
            if (!last) assert_false(take(cut((uint32_t)k, orders[k][i]), 7, 0));
        }
        assert_string_equal(p.channel, "LARGE");
        assert_int_equal(p.size, LARGE);
        assert_memory_equal(p.data, message, LARGE);
    }
    assert_int_equal(r.dropped, 9);
}

/* Messages of two senders with the same sequence number stay apart; a lost fragment costs its
 * message, after a second or at the next message of its sender. */
TEST(senders_and_losses)
{
    for (unsigned i = 0; i < 3; i++) {
        assert_false(take(cut(1, i), 7, 0));
        assert_false(take(cut(1, i), 8, 0));
    }
    assert_true(take(cut(1, 3), 8, 0));
    assert_int_equal(p.sender, 8);
    assert_false(take(cut(1, 3), 7, 1000001)); /* too late */
    assert_int_equal(r.dropped, 1);
    assert_false(take(cut(1, 2), 7, 0)); /* the clock went back */
    assert_int_equal(r.dropped, 2);
    for (unsigned i = 0; i < 4; i++) assert_int_equal(take(cut(2, i), 7, 0), i == 3);
    assert_int_equal(r.dropped, 3);
}

TEST(wrapped_and_overlapping_sizes)
{
    static const fragment bad[] = {
        {.size = 100, .offset = 0xffffffe0, .number = 0, .n = 2, .bytes = 64}, /* wraps 32 bits */
        {.size = 100, .offset = 37, .number = 1, .n = 2, .bytes = 64},
        {.size = 0xffffffff, .offset = 0, .number = 1, .n = 2, .bytes = 64},
        {.size = MUKCA_LCM_MAX_MESSAGE + 1, .offset = 0, .number = 1, .n = 2, .bytes = 64},
        {.size = 100, .offset = 0, .number = 1, .n = 2, .bytes = 0},
        {.size = 0, .offset = 0, .number = 1, .n = 2, .bytes = 0},
        {.size = 100, .offset = 0, .number = 2, .n = 2, .bytes = 10},
        {.size = 100, .offset = 0, .number = 1, .n = 0, .bytes = 10},
        {.size = 100, .offset = 0, .number = 1, .n = 65535, .bytes = 10},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_false(take(make_fragment("ARM", &bad[i]), 7, 0));
    assert_int_equal(r.dropped, 9);
    assert_part(r.reason, "outside");
    /* overlap, and so a gap: nothing is delivered */
    fragment f = {.sequence = 5, .size = 100, .offset = 0, .number = 0, .n = 2, .bytes = 50};
    assert_false(take(make_fragment("ARM", &f), 7, 0));
    f.number = 1;
    f.offset = 40;
    assert_false(take(make_fragment("ARM", &f), 7, 0));
    /* a second opinion about the size ends the message */
    f = (fragment){.sequence = 6, .size = 100, .offset = 0, .number = 0, .n = 2, .bytes = 50};
    assert_false(take(make_fragment("ARM", &f), 7, 0));
    f.size = 200;
    assert_false(take(make_fragment("ARM", &f), 7, 0));
    assert_int_equal(r.dropped, 11);
    assert_part(r.reason, "incomplete");
}

/* Beginnings of large messages from one sender and from many. */
TEST(partial_messages_are_bounded)
{
    const size_t before = mallinfo2().hblkhd; /* bytes of large allocations */
    assert_false(take(cut(1, 0), 7, 1));      /* of a well-behaved sender */
    for (uint32_t i = 0; i < 10000; i++) {
        const fragment f = {.sequence = i, .size = 6 << 20, .number = 1, .n = 200, .bytes = 9};
        assert_false(take(make_fragment("ARM", &f), 8, 1));
    }
    for (unsigned i = 1; i < 4; i++) assert_int_equal(take(cut(1, i), 7, 1), i == 3);
    for (uint32_t i = 0; i < 10000; i++) {
        const fragment f = {.sequence = i, .size = 6 << 20, .number = 1, .n = 200, .bytes = 9};
        assert_false(take(make_fragment("ARM", &f), 100 + i % 1000, i));
        assert_true(mallinfo2().hblkhd - before <= MUKCA_LCM_MAX_PARTIALS * ((6 << 20) + 10000));
    }
}

static size_t count(const mukca_lcm_queue *q)
{
    size_t n = 0;
    for (const mukca_lcm_queued *e = q->first; e; e = e->next) n++;
    return n;
}

TEST(the_queue_keeps_order_and_bounds)
{
    mukca_lcm_queue *q = zeroed(1, sizeof *q);
    mukca_lcm_queued *e;
    mukca_random random = mukca_random_seeded(1);
    int64_t pushed = 0, taken = 0, last = -1;
    for (int i = 0; i < 200000; i++) {
        const size_t size =
            (size_t)mukca_random_below(&random, mukca_random_below(&random, 50) ? 2000 : LARGE);
        p = (mukca_lcm_packet){
            .channel = "ARM", .data = message, .size = size, .time = i, .sender = (uint64_t)i % 7};
        pushed += mukca_lcm_queue_push(q, &p);
        assert_true(q->bytes <= MUKCA_LCM_QUEUE_BYTES);
        if (mukca_random_below(&random, 3) || !(e = mukca_lcm_queue_take(q))) continue;
        assert_string_equal(e->packet.channel, "ARM");
        assert_true(e->packet.time > last);
        assert_memory_equal(e->packet.data, message, e->packet.size);
        last = e->packet.time;
        taken++;
        free(e);
    }
    assert_true(q->dropped > 0 && taken > 1000);
    for (; (e = mukca_lcm_queue_take(q)); free(e)) {
        assert_true(e->packet.time > last);
        last = e->packet.time;
        taken++;
    }
    assert_int_equal(taken + q->dropped, pushed);
    assert_true(!q->first && q->bytes == 0);
    /* a stalled reader finds the latest messages of a stream, and those of others, in order */
    p = (mukca_lcm_packet){.channel = "TRIGGER", .data = message, .size = 10, .sender = 2};
    assert_true(mukca_lcm_queue_push(q, &p));
    p.channel = "ARM";
    p.sender = 1;
    for (p.time = 1; p.time <= 100000; p.time++) assert_true(mukca_lcm_queue_push(q, &p));
    const int64_t share = (int64_t)count(q) - 1;
    assert_true(share > 1000);
    for (int i = 0; (e = mukca_lcm_queue_take(q)); free(e), i++)
        assert_int_equal(e->packet.time, i ? 100000 - share + i : 0);
    /* many senders: the largest gives way */
    for (int k = 3; k < 100; k++) {
        p.sender = (uint64_t)k;
        for (int i = 0; i < 1000; i++) mukca_lcm_queue_push(q, &p);
    }
    assert_true(q->bytes <= MUKCA_LCM_QUEUE_BYTES && count(q) > 2000);
    p.sender = 3;
    p.time = 7;
    assert_true(mukca_lcm_queue_push(q, &p));
    int found = 0;
    for (; (e = mukca_lcm_queue_take(q)); free(e)) found += e->packet.time == 7;
    assert_int_equal(found, 1);
    /* room for one large message is not taken from small ones alone */
    char *large = zeroed(1, MUKCA_LCM_MAX_MESSAGE);
    p = (mukca_lcm_packet){.channel = "ARM", .data = message, .size = 10, .sender = 1};
    for (int i = 0; i < 900; i++) assert_true(mukca_lcm_queue_push(q, &p));
    p.data = (unsigned char *)large;
    p.size = MUKCA_LCM_MAX_MESSAGE / 2;
    for (p.sender = 2; p.sender < 4; p.sender++) assert_true(mukca_lcm_queue_push(q, &p));
    p.size = MUKCA_LCM_MAX_MESSAGE;
    assert_true(mukca_lcm_queue_push(q, &p));
    for (found = 0; (e = mukca_lcm_queue_take(q)); free(e)) found += e->packet.sender == 1;
    assert_true(found > 400);
    free(large);
    free(q);
}

TEST_EACH(reset, reset)
