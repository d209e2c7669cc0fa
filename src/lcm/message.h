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

/* data/lcm describes each field; message.c lists the members in their order.  Texts are
 * NUL-terminated; the sender owns them, or they point into the received message.  NULL is sent as
 * "". */
typedef struct {
    int64_t utime, id;
    const char *placement, *socket;
} mukca_message_trigger;

typedef struct {
    int64_t utime, id;
    const char *verb;
    int n;
    const char *argument[MUKCA_MESSAGE_ARGUMENTS];
} mukca_message_command;

typedef struct {
    int64_t utime;
    const char *state, *text, *session, *placement, *socket;
    int rows, rows_here;
    const char *channel, *type, *stream;
    double rate_hz, age_s;
    int64_t received, refused;
    bool still;
    double spread_m, expected_m;
    bool more_rows_help;
    int n;
    const char *joint[MUKCA_MAX_JOINTS];
    double position[MUKCA_MAX_JOINTS], coverage[MUKCA_MAX_JOINTS];
} mukca_message_status;

typedef struct {
    int64_t utime, id;
    bool accepted;
    const char *text, *placement, *socket;
    int row, n;
    const char *joint[MUKCA_MAX_JOINTS];
    double position[MUKCA_MAX_JOINTS], spread[MUKCA_MAX_JOINTS];
} mukca_message_sample;

typedef struct {
    int64_t utime, id;
    const char *verb;
    int code;
    const char *text, *robot, *urdf_sha256, *base, *tip, *stream;
    int n;
    const char *joint[MUKCA_MESSAGE_ROWS], *parameter[MUKCA_MESSAGE_ROWS],
        *unit[MUKCA_MESSAGE_ROWS];
    double nominal[MUKCA_MESSAGE_ROWS], calibrated[MUKCA_MESSAGE_ROWS], offset[MUKCA_MESSAGE_ROWS],
        sigma[MUKCA_MESSAGE_ROWS];
    bool identifiable[MUKCA_MESSAGE_ROWS];
    const char *json;
} mukca_message_result;

typedef struct {
    int64_t utime;
    double position[3], quaternion[4];
} mukca_message_pose;

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
