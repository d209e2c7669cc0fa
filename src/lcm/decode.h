/* Bounded, table-driven decoder of LCM messages that carry joint states. */
#ifndef MUKCA_LCM_DECODE_H
#define MUKCA_LCM_DECODE_H

#include "lcm/type.h"

/* Decoded joint states of one message. */
typedef struct {
    int64_t time; /* us, by the sender's clock; 0: the type has no time */
    bool guided;  /* a person is guiding the arm by hand */
    int n;        /* number of joints */
    bool has[MUKCA_LCM_ROLES];
    const char *name[MUKCA_LCM_MAX_JOINTS]; /* points into the message */
    /* rad, rad/s, N m, rad; by role */
    double value[MUKCA_LCM_ROLES][MUKCA_LCM_MAX_JOINTS];
} mukca_lcm_joints;

/* Index of the type of message data[size] by its fingerprint, -1: unknown.  Later types take
 * precedence. */
int mukca_lcm_types_find(const mukca_lcm_types *types, const void *data, size_t size);

/* Decode a message of type `type` from data[size].  Reads within data only, in time linear in
 * `size`, without allocation.  Errors: MUKCA_INPUT (truncated, excess bytes, counts that exceed the
 * message or 64 joints, unequal lengths, positions that are not finite). */
mukca_status mukca_lcm_decode_joints(mukca_lcm_joints *joints, const mukca_lcm_types *types,
                                     int type, const void *data, size_t size, mukca_error *error);

#endif
