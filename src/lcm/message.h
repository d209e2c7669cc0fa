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

/* The members of each message, in the order of data/lcm, which describes them: X of values, A of an
 * array and its capacity.  Arrays have as many elements as the COUNT before them; without one, all.
 */
#define MUKCA_MESSAGE_TRIGGER_MEMBERS(X, A) \
    X(INT64, utime, id)                     \
    X(TEXT, placement, socket)

#define MUKCA_MESSAGE_COMMAND_MEMBERS(X, A) \
    X(INT64, utime, id)                     \
    X(TEXT, verb)                           \
    X(COUNT, n)                             \
    A(TEXT, argument, MUKCA_MESSAGE_ARGUMENTS)

#define MUKCA_MESSAGE_STATUS_MEMBERS(X, A)           \
    X(INT64, utime)                                  \
    X(TEXT, state, text, session, placement, socket) \
    X(INT32, rows, rows_here)                        \
    X(TEXT, channel, type, stream)                   \
    X(REAL, rate_hz, age_s)                          \
    X(INT64, received, refused)                      \
    X(FLAG, still)                                   \
    X(REAL, spread_m, expected_m)                    \
    X(FLAG, more_rows_help)                          \
    X(COUNT, n)                                      \
    A(TEXT, joint, MUKCA_MAX_JOINTS)                 \
    A(REAL, position, MUKCA_MAX_JOINTS)              \
    A(REAL, coverage, MUKCA_MAX_JOINTS)

#define MUKCA_MESSAGE_SAMPLE_MEMBERS(X, A) \
    X(INT64, utime, id)                    \
    X(FLAG, accepted)                      \
    X(TEXT, text, placement, socket)       \
    X(INT32, row)                          \
    X(COUNT, n)                            \
    A(TEXT, joint, MUKCA_MAX_JOINTS)       \
    A(REAL, position, MUKCA_MAX_JOINTS)    \
    A(REAL, spread, MUKCA_MAX_JOINTS)

#define MUKCA_MESSAGE_RESULT_MEMBERS(X, A)               \
    X(INT64, utime, id)                                  \
    X(TEXT, verb)                                        \
    X(INT32, code)                                       \
    X(TEXT, text, robot, urdf_sha256, base, tip, stream) \
    X(COUNT, n)                                          \
    A(TEXT, joint, MUKCA_MESSAGE_ROWS)                   \
    A(TEXT, parameter, MUKCA_MESSAGE_ROWS)               \
    A(TEXT, unit, MUKCA_MESSAGE_ROWS)                    \
    A(REAL, nominal, MUKCA_MESSAGE_ROWS)                 \
    A(REAL, calibrated, MUKCA_MESSAGE_ROWS)              \
    A(REAL, offset, MUKCA_MESSAGE_ROWS)                  \
    A(REAL, sigma, MUKCA_MESSAGE_ROWS)                   \
    A(FLAG, identifiable, MUKCA_MESSAGE_ROWS)            \
    X(TEXT, json)

#define MUKCA_MESSAGE_POSE_MEMBERS(X, A) \
    X(INT64, utime)                      \
    A(REAL, position, 3)                 \
    A(REAL, quaternion, 4)

typedef int64_t mukca_message_INT64;
typedef int mukca_message_INT32, mukca_message_COUNT;
typedef double mukca_message_REAL;
typedef bool mukca_message_FLAG;
typedef const char *mukca_message_TEXT;

/* mukca_message_trigger and so on.  Texts are NUL-terminated; the sender owns them, or they point
 * into the received message.  NULL is sent as "". */
#define MUKCA_MESSAGE_VALUES(kind, ...) mukca_message_##kind __VA_ARGS__;
#define MUKCA_MESSAGE_ARRAY(kind, name, most) mukca_message_##kind name[most];
#define MUKCA_MESSAGE_STRUCT(channel, name, fingerprint)                             \
    typedef struct {                                                                 \
        MUKCA_MESSAGE_##channel##_MEMBERS(MUKCA_MESSAGE_VALUES, MUKCA_MESSAGE_ARRAY) \
    } mukca_message_##name;
MUKCA_MESSAGE_LIST(MUKCA_MESSAGE_STRUCT)
#undef MUKCA_MESSAGE_STRUCT

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
