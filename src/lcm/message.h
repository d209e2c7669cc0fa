/* mukca's own LCM messages (package mukca, data/lcm): C structs, encoding and decoding. */
#ifndef MUKCA_LCM_MESSAGE_H
#define MUKCA_LCM_MESSAGE_H

#include "lcm/packet.h"
#include "mukca/chain.h"
#include "mukca/status.h"

/* channel, struct mukca_message_NAME, fingerprint by lcm-gen 1.3.1 (a test compares data/lcm) */
#define MUKCA_MESSAGE_LIST(X)               \
    X(TRIGGER, trigger, 0x7e17a1d01fe0e2fb) \
    X(COMMAND, command, 0x9ed4cb80fd4c8cd9) \
    X(STATUS, status, 0xed12f1132393a392)   \
    X(SAMPLE, sample, 0x117e02e881428d9b)   \
    X(RESULT, result, 0x07050f18097d47d5)   \
    X(POSE, pose, 0x645cdf5dd6a54db9)

typedef enum {
#define MUKCA_MESSAGE_ENUM(channel, name, fingerprint) MUKCA_MESSAGE_##channel,
    MUKCA_MESSAGE_LIST(MUKCA_MESSAGE_ENUM)
#undef MUKCA_MESSAGE_ENUM
        MUKCA_MESSAGES
} mukca_message_kind;

enum {
    MUKCA_MESSAGE_ARGUMENTS = 8,
    MUKCA_MESSAGE_ROWS = 512 /* largest number of rows of an offsets table */
};

/* The members of each struct in the order of data/lcm, which describes them: ONE, or MANY, an array
 * of some capacity, of which as many elements are sent as the last int before it says, without one
 * all.  Texts are NUL-terminated; the sender owns them, or they point into the received message.
 * NULL is sent as "".  `of` is for the caller's macros. */
#define MUKCA_MESSAGE_TRIGGER_LIST(ONE, MANY, of) \
    ONE(of, int64_t, utime)                       \
    ONE(of, int64_t, id)                          \
    ONE(of, const char *, placement)              \
    ONE(of, const char *, socket)

#define MUKCA_MESSAGE_COMMAND_LIST(ONE, MANY, of) \
    ONE(of, int64_t, utime)                       \
    ONE(of, int64_t, id)                          \
    ONE(of, const char *, verb)                   \
    ONE(of, int, n)                               \
    MANY(of, const char *, argument, MUKCA_MESSAGE_ARGUMENTS)

#define MUKCA_MESSAGE_STATUS_LIST(ONE, MANY, of)    \
    ONE(of, int64_t, utime)                         \
    ONE(of, const char *, state)                    \
    ONE(of, const char *, text)                     \
    ONE(of, const char *, session)                  \
    ONE(of, const char *, placement)                \
    ONE(of, const char *, socket)                   \
    ONE(of, int, rows)                              \
    ONE(of, int, rows_here)                         \
    ONE(of, const char *, channel)                  \
    ONE(of, const char *, type)                     \
    ONE(of, const char *, stream)                   \
    ONE(of, double, rate_hz)                        \
    ONE(of, double, age_s)                          \
    ONE(of, int64_t, received)                      \
    ONE(of, int64_t, refused)                       \
    ONE(of, bool, still)                            \
    ONE(of, double, spread_m)                       \
    ONE(of, double, expected_m)                     \
    ONE(of, bool, more_rows_help)                   \
    ONE(of, int, n)                                 \
    MANY(of, const char *, joint, MUKCA_MAX_JOINTS) \
    MANY(of, double, position, MUKCA_MAX_JOINTS)    \
    MANY(of, double, coverage, MUKCA_MAX_JOINTS)

#define MUKCA_MESSAGE_SAMPLE_LIST(ONE, MANY, of)    \
    ONE(of, int64_t, utime)                         \
    ONE(of, int64_t, id)                            \
    ONE(of, bool, accepted)                         \
    ONE(of, const char *, text)                     \
    ONE(of, const char *, placement)                \
    ONE(of, const char *, socket)                   \
    ONE(of, int, row)                               \
    ONE(of, int, n)                                 \
    MANY(of, const char *, joint, MUKCA_MAX_JOINTS) \
    MANY(of, double, position, MUKCA_MAX_JOINTS)    \
    MANY(of, double, spread, MUKCA_MAX_JOINTS)

#define MUKCA_MESSAGE_RESULT_LIST(ONE, MANY, of)          \
    ONE(of, int64_t, utime)                               \
    ONE(of, int64_t, id)                                  \
    ONE(of, const char *, verb)                           \
    ONE(of, int, code)                                    \
    ONE(of, const char *, text)                           \
    ONE(of, const char *, robot)                          \
    ONE(of, const char *, urdf_sha256)                    \
    ONE(of, const char *, base)                           \
    ONE(of, const char *, tip)                            \
    ONE(of, const char *, stream)                         \
    ONE(of, int, n)                                       \
    MANY(of, const char *, joint, MUKCA_MESSAGE_ROWS)     \
    MANY(of, const char *, parameter, MUKCA_MESSAGE_ROWS) \
    MANY(of, const char *, unit, MUKCA_MESSAGE_ROWS)      \
    MANY(of, double, nominal, MUKCA_MESSAGE_ROWS)         \
    MANY(of, double, calibrated, MUKCA_MESSAGE_ROWS)      \
    MANY(of, double, offset, MUKCA_MESSAGE_ROWS)          \
    MANY(of, double, sigma, MUKCA_MESSAGE_ROWS)           \
    MANY(of, bool, identifiable, MUKCA_MESSAGE_ROWS)      \
    ONE(of, const char *, json)

#define MUKCA_MESSAGE_POSE_LIST(ONE, MANY, of) \
    ONE(of, int64_t, utime)                    \
    MANY(of, double, position, 3)              \
    MANY(of, double, quaternion, 4)

#define MUKCA_MESSAGE_ONE(of, type, name) type name;
#define MUKCA_MESSAGE_MANY(of, type, name, capacity) type name[capacity];
#define MUKCA_MESSAGE_STRUCT(channel, name, fingerprint)                        \
    typedef struct {                                                            \
        MUKCA_MESSAGE_##channel##_LIST(MUKCA_MESSAGE_ONE, MUKCA_MESSAGE_MANY, ) \
    } mukca_message_##name;
MUKCA_MESSAGE_LIST(MUKCA_MESSAGE_STRUCT)
#undef MUKCA_MESSAGE_STRUCT
#undef MUKCA_MESSAGE_MANY
#undef MUKCA_MESSAGE_ONE

/* Channel of a message: PREFIX_TRIGGER and so on; `prefix` NULL means MUKCA. */
void mukca_message_channel(char channel[64], mukca_message_kind kind, const char *prefix);

/* Type name of data[size], for instance "mukca.status"; NULL: not a mukca message. */
const char *mukca_message_identify(const void *data, size_t size);

/* Encode `message` (the struct of `kind`) to buffer[size].  Returns the bytes required, which may
 * exceed `size` (the buffer is then incomplete); 0: a count is out of range.  Does not allocate.
 * `buffer` may be NULL with size 0. */
size_t mukca_message_encode(void *buffer, size_t size, mukca_message_kind kind,
                            const void *message);

/* Decode data[size] into the struct of `kind`; the signature after a request is
 * not checked.  Errors: MUKCA_INPUT (another type, malformed). */
mukca_status mukca_message_decode(void *message, mukca_message_kind kind, const void *data,
                                  size_t size, mukca_error *error);

/* ---- signatures of requests: HMAC-SHA256 (RFC 2104) appended to the message ---- */

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
