/* mukca's own LCM messages: the lists of their members drive encoding and decoding; their
 * signatures.
 */
#include "lcm/message.h"

#include <ctype.h>
#include <sha2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/text.h"
#include "lcm/type.h"

/* A member of a message's struct. */
typedef struct {
    size_t at, size; /* offset; bytes of an element, 0: the end of the list */
    mukca_lcm_primitive type;
    int capacity; /* of an array, 0: none */
} member;

#define TYPE(type) \
    _Generic((type *)NULL,             \
        int64_t *: MUKCA_LCM_INT64,    \
        int *: MUKCA_LCM_INT32,        \
        double *: MUKCA_LCM_DOUBLE,    \
        bool *: MUKCA_LCM_BOOLEAN,     \
        const char **: MUKCA_LCM_STRING)
#define ONE(of, type, name) {offsetof(of, name), sizeof(type), TYPE(type), 0},
#define MANY(of, type, name, capacity) {offsetof(of, name), sizeof(type), TYPE(type), capacity},
#define MEMBERS(channel, name, fingerprint)  \
    static const member name##_members[] = { \
        MUKCA_MESSAGE_##channel##_LIST(ONE, MANY, mukca_message_##name){.size = 0}};
MUKCA_MESSAGE_LIST(MEMBERS)

static const struct {
    const char *channel, *name;
    uint64_t fingerprint;
    const member *members;
} kinds[] = {
#define KIND(channel, name, fingerprint) {#channel, "mukca." #name, fingerprint, name##_members},
    MUKCA_MESSAGE_LIST(KIND)
#undef KIND
};

/* Number of elements of a member, negative: out of range; n: the last int before it, or NULL. */
static int count_elements(const member *m, const int *n)
{
    if (m->capacity == 0) return 1;
    return !n ? m->capacity : *n <= m->capacity ? *n : -1;
}

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

static void put_element(writer *w, mukca_lcm_primitive type, const void *from)
{
    uint64_t number;
    if (type == MUKCA_LCM_STRING) {
        const char *const *given = from, *text = *given ? *given : "";
        const size_t size = strlen(text) + 1;
        put(w, NULL, size, 4);
        put(w, text, 0, size);
        if (w->used <= w->size) mukca_utf8_mend((char *)w->at + w->used - size);
        return;
    }
    if (type == MUKCA_LCM_BOOLEAN)
        number = *(const bool *)from;
    else if (type == MUKCA_LCM_INT32)
        number = (uint32_t) * (const int *)from;
    else
        memcpy(&number, from, sizeof number);
    put(w, NULL, number, mukca_lcm_primitive_sizes[type]);
}

size_t mukca_message_encode(void *buffer, size_t size, mukca_message_kind kind, const void *message)
{
    writer out = {.at = buffer, .size = size};
    put(&out, NULL, kinds[kind].fingerprint, 8);
    const int *n = NULL;
    for (const member *m = kinds[kind].members; m->size; m++) {
        const char *at = (const char *)message + m->at;
        const int count = count_elements(m, n);
        if (count < 0) return 0;
        for (int k = 0; k < count; k++) put_element(&out, m->type, at + (size_t)k * m->size);
        if (m->type == MUKCA_LCM_INT32) n = (const void *)at;
    }
    return out.used;
}

/* ---- decode ---- */

static bool decode_element(mukca_lcm_wire *wire, mukca_lcm_primitive type, void *to)
{
    if (type == MUKCA_LCM_STRING) {
        const char **text = to;
        *text = mukca_lcm_wire_text(wire);
        return *text != NULL; /* who uses it checks it, and answers */
    }
    const int size = mukca_lcm_primitive_sizes[type];
    const unsigned char *at = mukca_lcm_wire_bytes(wire, (size_t)size);
    if (!at) return false;
    const uint64_t number = mukca_lcm_wire_get(at, size);
    if (type == MUKCA_LCM_BOOLEAN)
        *(bool *)to = number != 0;
    else if (type == MUKCA_LCM_INT32)
        *(int *)to = (int)(uint32_t)number;
    else
        memcpy(to, &number, sizeof number);
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
    const int *n = NULL;
    for (const member *m = kinds[kind].members; good && m->size; m++) {
        char *at = (char *)message + m->at;
        const int count = count_elements(m, n);
        good = count >= 0;
        for (int k = 0; k < count && good; k++)
            good = decode_element(&wire, m->type, at + (size_t)k * m->size);
        if (m->type == MUKCA_LCM_INT32) n = (const void *)at;
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
