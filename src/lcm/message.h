/* Our own LCM messages (package mukca, data/lcm): as C structs, to the wire and back. */
#ifndef MUKCA_LCM_MESSAGE_H
#define MUKCA_LCM_MESSAGE_H

#include "lcm/type.h"

enum { MUKCA_MESSAGE_ARGUMENTS = 8, MUKCA_MESSAGE_ROWS = 512 };

/* Texts are NUL-terminated and belong to the sender, or point into the received message.  NULL is
 * sent as "". */
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

/* Channel of our messages: PREFIX_TRIGGER and so on; `prefix` NULL is MUKCA. */
void mukca_message_channel(char channel[64], mukca_lcm_builtin kind, const char *prefix);

/* Encode `message` (the struct of `kind`, MUKCA_LCM_TRIGGER to MUKCA_LCM_POSE) to buffer[size].
 * Returns the bytes it takes, which may exceed `size` (then only the count is right); 0 where a
 * count in it is out of range.  Allocates nothing.  `buffer` may be NULL with size 0. */
size_t mukca_message_encode(void *buffer, size_t size, mukca_lcm_builtin kind, const void *message,
                            const mukca_lcm_types *types);

/* Decode data[size] into the struct of `kind`.  Errors: MUKCA_INPUT (another type, malformed). */
mukca_status mukca_message_decode(void *message, mukca_lcm_builtin kind, const void *data,
                                  size_t size, const mukca_lcm_types *types, mukca_error *error);

#endif
