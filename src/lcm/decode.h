/* Bounded, table-driven decoder of LCM messages that carry joint states. */
#ifndef MUKCA_LCM_DECODE_H
#define MUKCA_LCM_DECODE_H

#include "lcm/type.h"

/* One message of joint states, decoded. */
typedef struct {
    int64_t time; /* us, the sender's; 0 where the type has none */
    bool guided;  /* a person moves the arm by hand now */
    int n;        /* joints */
    bool has[MUKCA_LCM_ROLES];
    const char *name[MUKCA_LCM_MAX_JOINTS]; /* into the message */
    /* rad, rad/s, N m, rad; by role */
    double value[MUKCA_LCM_ROLES][MUKCA_LCM_MAX_JOINTS];
} mukca_lcm_joints;

/* Decode a message of type `type` from data[size].  Reads nothing outside, takes time linear in
 * `size`, and allocates nothing.  Errors: MUKCA_INPUT (short, left-over bytes, counts that do not
 * fit or exceed 64 joints, unequal lengths, positions that are no numbers). */
mukca_status mukca_lcm_decode_joints(mukca_lcm_joints *joints, const mukca_lcm_types *types,
                                     int type, const void *data, size_t size, mukca_error *error);

#endif
