/* mukca's own LCM messages: one layout per type drives encoding and decoding; their signatures. */
#include "lcm/message.h"

#include <ctype.h>
#include <sha2.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/utf8.h"

typedef enum { INT64, INT32, REAL, FLAG, TEXT, COUNT, END } member_kind;
static const size_t wire_size[] = {8, 4, 8, 1, 4, 4}; /* of a text: size of its length */
static const size_t member_size[] = {sizeof(int64_t), sizeof(int),    sizeof(double),
                                     sizeof(bool),    sizeof(char *), sizeof(int)};

typedef struct {
    member_kind kind;
    bool array; /* else values side by side */
    int most;   /* their number, or the capacity */
    size_t at;  /* in the struct */
} member;

/* Members of a message, ended by END. */
static const member *members_of(mukca_message_kind message)
{
#define FIRST(name, ...) name
#define VALUES(kind, ...)                                                                 \
    {kind, false,                                                                         \
     sizeof(struct { mukca_message_##kind __VA_ARGS__; }) / sizeof(mukca_message_##kind), \
     offsetof(of, FIRST(__VA_ARGS__, ))},
#define ARRAY(kind, name, most) {kind, true, most, offsetof(of, name)},
#define MEMBERS(channel, name, fingerprint)                                      \
    if (message == MUKCA_MESSAGE_##channel) {                                    \
        typedef mukca_message_##name of;                                         \
        static const member list[] = {                                           \
            MUKCA_MESSAGE_##channel##_MEMBERS(VALUES, ARRAY){END, false, 0, 0}}; \
        return list;                                                             \
    }
    static const member none = {.kind = END};
    MUKCA_MESSAGE_LIST(MEMBERS)
    return &none;
}

/* Read n of the next arrays; false: out of range. */
static bool read_count(int *n, const member *m, const void *at)
{
    memcpy(n, at, sizeof *n);
    return *n >= 0 && *n <= m[1].most;
}

/* Number of elements; n: as read, -1 before. */
static int elements(const member *m, int n)
{
    return m->array && n >= 0 ? n : m->most;
}

static const struct {
    const char *channel, *name;
    uint64_t fingerprint;
} kinds[] = {
#define KIND(channel, name, fingerprint) {#channel, "mukca." #name, fingerprint},
    MUKCA_MESSAGE_LIST(KIND)
#undef KIND
};

void mukca_message_channel(char channel[64], mukca_message_kind kind, const char *prefix)
{
    snprintf(channel, 64, "%.50s_%s", prefix ? prefix : "MUKCA", kinds[kind].channel);
}

const char *mukca_message_identify(const void *data, size_t size)
{
    for (int k = 0; k < MUKCA_MESSAGES && size >= 8; k++)
        if (mukca_lcm_wire_get(data, 8) == kinds[k].fingerprint) return kinds[k].name;
    return NULL;
}

/* ---- encode ---- */

typedef struct {
    unsigned char *at;
    size_t size, used; /* nothing is written once `used` exceeds `size` */
} writer;

static void put(writer *w, const void *bytes, uint64_t number, size_t n)
{
    if (w->used <= w->size && n <= w->size - w->used) {
        if (bytes)
            memcpy(w->at + w->used, bytes, n);
        else
            mukca_lcm_wire_put(w->at + w->used, number, (int)n);
    }
    w->used += n;
}

static void put_element(writer *w, member_kind kind, const char *at)
{
    const char *text = NULL;
    uint64_t number = 0;
    int small = 0;
    bool flag = false;
    switch (kind) {
        case TEXT:
            memcpy(&text, at, sizeof text);
            if (!text) text = "";
            put(w, NULL, strlen(text) + 1, 4);
            put(w, text, 0, strlen(text) + 1);
            if (w->used <= w->size) mukca_utf8_mend((char *)w->at + w->used - strlen(text) - 1);
            return;
        case FLAG:
            memcpy(&flag, at, sizeof flag);
            number = flag;
            break;
        case INT32:
        case COUNT:
            memcpy(&small, at, sizeof small);
            number = (uint32_t)small;
            break;
        case INT64:
        case REAL:
            memcpy(&number, at, sizeof number);
            break;
        case END:
            break;
    }
    put(w, NULL, number, wire_size[kind]);
}

size_t mukca_message_encode(void *buffer, size_t size, mukca_message_kind kind, const void *message)
{
    writer out = {.at = buffer, .size = size};
    int n = -1;
    put(&out, NULL, kinds[kind].fingerprint, 8);
    for (const member *m = members_of(kind); m->kind != END; m++) {
        const char *at = (const char *)message + m->at;
        if (m->kind == COUNT && !read_count(&n, m, at)) return 0;
        for (int k = 0; k < elements(m, n); k++)
            put_element(&out, m->kind, at + (size_t)k * member_size[m->kind]);
    }
    return out.used;
}

/* ---- decode ---- */

/* Whether a text has no characters that control a terminal. */
static bool is_printable(const char *text)
{
    for (const char *c = text; *c; c++)
        if (((unsigned char)*c < 0x20 && *c != '\t' && *c != '\n') || *c == 0x7f) return false;
    return true;
}

static bool decode_element(mukca_lcm_wire *wire, member_kind kind, char *to)
{
    if (kind == TEXT) {
        const char *text = mukca_lcm_wire_text(wire);
        memcpy(to, &text, sizeof text);
        return text && is_printable(text);
    }
    const unsigned char *at = mukca_lcm_wire_bytes(wire, wire_size[kind]);
    if (!at) return false;
    uint64_t number = mukca_lcm_wire_get(at, (int)wire_size[kind]);
    int small = (int)(uint32_t)number;
    bool flag = number != 0;
    const void *value = kind == FLAG                     ? (const void *)&flag
                        : kind == INT32 || kind == COUNT ? (const void *)&small
                                                         : (const void *)&number;
    memcpy(to, value, member_size[kind]);
    return true;
}

mukca_status mukca_message_decode(void *message, mukca_message_kind kind, const void *data,
                                  size_t size, mukca_error *error)
{
    mukca_lcm_wire wire = {.at = data, .left = size};
    const unsigned char *head = mukca_lcm_wire_bytes(&wire, 8);
    if (!head || mukca_lcm_wire_get(head, 8) != kinds[kind].fingerprint)
        return mukca_fail(error, MUKCA_INPUT, "not a %s message", kinds[kind].name);
    bool good = true;
    int n = -1;
    for (const member *m = members_of(kind); good && m->kind != END; m++) {
        char *at = (char *)message + m->at;
        for (int k = 0; k < elements(m, n) && good; k++)
            good = decode_element(&wire, m->kind, at + (size_t)k * member_size[m->kind]);
        if (good && m->kind == COUNT) good = read_count(&n, m, at);
    }
    const bool request = kind == MUKCA_MESSAGE_TRIGGER || kind == MUKCA_MESSAGE_COMMAND;
    if (request && wire.left == MUKCA_LCM_SIGNATURE) wire.left = 0;
    if (!good || wire.left)
        return mukca_fail(error, MUKCA_INPUT, "malformed %s message", kinds[kind].name);
    return MUKCA_OK;
}

/* ---- signatures of requests, with the SHA-256 of libmd ---- */

enum { SHORTEST = 16 /* bytes; 128 bits if random, RFC 2104 section 3 */ };

mukca_status mukca_lcm_key_read(mukca_lcm_key *key, const char *path, mukca_error *error)
{
    struct stat info;
    char *text;
    *key = (mukca_lcm_key){.block = {0}};
    if (stat(path, &info) == 0 && S_ISREG(info.st_mode) && info.st_mode & (S_IROTH | S_IWOTH))
        return mukca_fail(error, MUKCA_INPUT,
                          "%s: any user can read or write this key; chmod o= it",
                          mukca_file_shown(path));
    mukca_status status = mukca_file_read(&text, path, error);
    if (status != MUKCA_OK) return status;
    size_t n = strlen(text);
    while (n && isspace((unsigned char)text[n - 1])) n--;
    if (n < SHORTEST) {
        status =
            mukca_fail(error, MUKCA_INPUT,
                       "%s: a key has at least %d characters; make one with: openssl rand -hex 32",
                       mukca_file_shown(path), (int)SHORTEST);
    } else if (n <= sizeof key->block) {
        memcpy(key->block, text, n);
    } else {
        SHA2_CTX hash;
        SHA256Init(&hash);
        SHA256Update(&hash, (const uint8_t *)text, n);
        SHA256Final(key->block, &hash);
    }
    memset(text, 0, n);
    free(text);
    return status;
}

/* Start a hash with the key's block, each byte XORed with `pad`. */
static void begin(SHA2_CTX *hash, const mukca_lcm_key *key, unsigned char pad)
{
    unsigned char block[MUKCA_LCM_KEY_BLOCK];
    for (int i = 0; i < MUKCA_LCM_KEY_BLOCK; i++) block[i] = key->block[i] ^ pad;
    SHA256Init(hash);
    SHA256Update(hash, block, sizeof block);
}

void mukca_lcm_signature_make(unsigned char signature[MUKCA_LCM_SIGNATURE],
                              const mukca_lcm_key *key, const mukca_lcm_packet *packet)
{
    SHA2_CTX hash;
    unsigned char inner[MUKCA_LCM_SIGNATURE];
    begin(&hash, key, 0x36);
    SHA256Update(&hash, (const uint8_t *)packet->channel, strlen(packet->channel) + 1);
    SHA256Update(&hash, packet->data, packet->size);
    SHA256Final(inner, &hash);
    begin(&hash, key, 0x5c);
    SHA256Update(&hash, inner, sizeof inner);
    SHA256Final(signature, &hash);
}

bool mukca_lcm_signature_check(const mukca_lcm_key *key, const mukca_lcm_packet *packet)
{
    unsigned char signature[MUKCA_LCM_SIGNATURE], difference = 0;
    if (packet->size < MUKCA_LCM_SIGNATURE) return false;
    mukca_lcm_packet content = *packet;
    content.size -= MUKCA_LCM_SIGNATURE;
    mukca_lcm_signature_make(signature, key, &content);
    const unsigned char *claimed = (const unsigned char *)packet->data + content.size;
    /* compare all bytes: the time must not depend on the number of matches */
    for (int i = 0; i < MUKCA_LCM_SIGNATURE; i++)
        difference = (unsigned char)(difference | (signature[i] ^ claimed[i]));
    return !difference;
}
