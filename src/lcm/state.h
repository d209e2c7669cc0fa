/* Built-in LCM types of joint states: one row here and one entry in state.c each. */
#ifndef MUKCA_LCM_STATE_H
#define MUKCA_LCM_STATE_H

#include "lcm/type.h"

/* name, type, usual channel (for help), fingerprint by lcm-gen 1.3.1 (for tests) */
#define MUKCA_LCM_STATE_LIST(X)                                                        \
    X(iiwa_status, "drake.lcmt_iiwa_status", "IIWA_STATUS", 0xf16fb804284abca3)        \
    X(panda_status, "drake.lcmt_panda_status", "PANDA_STATUS", 0x19571cdf4d82fae6)     \
    X(jaco_status, "drake.lcmt_jaco_status", "KINOVA_JACO_STATUS", 0x9bc39ecbb8de40c8) \
    X(robot_state, "drake.lcmt_robot_state", "any channel", 0x84cfb1722d58bd59)        \
    X(joint_state, "bot_core.joint_state_t", "any channel", 0x3e377b4cebc593a4)        \
    X(joint_angles, "bot_core.joint_angles_t", "any channel", 0x3e7cd307b8f9e790)

/* Indices of the rows; types from MUKCA_LCM_STATES on are the user's. */
enum {
#define MUKCA_LCM_STATE_INDEX(name, type, channel, fingerprint) MUKCA_LCM_STATE_##name,
    MUKCA_LCM_STATE_LIST(MUKCA_LCM_STATE_INDEX)
#undef MUKCA_LCM_STATE_INDEX
        MUKCA_LCM_STATES
};

/* Initialise `types` with the rows in their order.  Errors: none for a consistent table
 * (tested). */
mukca_status mukca_lcm_types_init(mukca_lcm_types *types, mukca_error *error);

#endif
