/* Signatures of requests: HMAC-SHA256 (RFC 2104) behind the bytes of the message. */
#ifndef MUKCA_LCM_SIGNATURE_H
#define MUKCA_LCM_SIGNATURE_H

#include "lcm/packet.h"
#include "mukca/status.h"

enum {
    MUKCA_LCM_SIGNATURE = 32, /* bytes */
    MUKCA_LCM_KEY_BLOCK = 64  /* bytes, of SHA-256 */
};

typedef struct {
    unsigned char block[MUKCA_LCM_KEY_BLOCK]; /* the key, or its hash, and zeros */
} mukca_lcm_key;

/* Read a key: the bytes of the file without white space at its end, at least 16.  Errors:
 * MUKCA_INPUT (cannot be read, too short, others may read it), MUKCA_MEMORY. */
mukca_status mukca_lcm_key_read(mukca_lcm_key *key, const char *path, mukca_error *error);

/* Signature of the packet's channel with its NUL and data[size]. */
void mukca_lcm_signature_make(unsigned char signature[MUKCA_LCM_SIGNATURE],
                              const mukca_lcm_key *key, const mukca_lcm_packet *packet);

/* Whether the last bytes of the packet are the signature of what precedes them. */
bool mukca_lcm_signature_check(const mukca_lcm_key *key, const mukca_lcm_packet *packet);

#endif
