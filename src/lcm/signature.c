/* Signatures of requests, with the SHA-256 of libmd. */
#include "lcm/message.h"

#include <ctype.h>
#include <sha2.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"

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
