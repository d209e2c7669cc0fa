/* Signatures of requests: HMAC-SHA256 (RFC 2104) appended to the message. */
#ifndef MUKCA_LCM_SIGNATURE_H
#define MUKCA_LCM_SIGNATURE_H

#include "lcm/packet.h"
#include "mukca/status.h"

enum {
    MUKCA_LCM_SIGNATURE = 32, /* bytes */
    MUKCA_LCM_KEY_BLOCK = 64  /* bytes, block size of SHA-256 */
};

typedef struct {
    unsigned char block[MUKCA_LCM_KEY_BLOCK]; /* the key or its hash, zero-padded */
} mukca_lcm_key;

/* Read a key: the bytes of the file without trailing white space, at least 16.  Errors: MUKCA_INPUT
 * (cannot be read, too short, readable by others), MUKCA_MEMORY. */
mukca_status mukca_lcm_key_read(mukca_lcm_key *key, const char *path, mukca_error *error);

/* Compute the signature of the packet's channel, including its NUL, and data[size]. */
void mukca_lcm_signature_make(unsigned char signature[MUKCA_LCM_SIGNATURE],
                              const mukca_lcm_key *key, const mukca_lcm_packet *packet);

/* Whether the last bytes of the packet are a valid signature of the preceding ones. */
bool mukca_lcm_signature_check(const mukca_lcm_key *key, const mukca_lcm_packet *packet);

#endif
