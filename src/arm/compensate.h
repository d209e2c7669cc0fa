/* Correction of joint targets: the calibrated arm reaches the poses that the nominal model
 * intended. */
#ifndef MUKCA_ARM_COMPENSATE_H
#define MUKCA_ARM_COMPENSATE_H

#include "mukca/corrected.h"
#include "mukca/row_state.h"

/* name in the output, description */
#define MUKCA_REACH_LIST(X)                                                        \
    X(OK, "ok", "reached")                                                         \
    X(LIMIT, "limit", "a joint's limit is in the way")                             \
    X(UNREACHED, "unreached", "the arm does not get there (too far, or singular)") \
    X(FAR, "far", "reached, but a joint has to move by more than 0.5 rad for it")  \
    X(JUMP, "jump", "reached, but the correction jumps from the row before")

typedef enum {
#define MUKCA_REACH_ENUM(name, text, sentence) MUKCA_REACH_##name,
    MUKCA_REACH_LIST(MUKCA_REACH_ENUM)
#undef MUKCA_REACH_ENUM
        MUKCA_REACH_COUNT
} mukca_reach;

extern const char *const mukca_reach_text[MUKCA_REACH_COUNT];
extern const char *const mukca_reach_sentence[MUKCA_REACH_COUNT];

typedef struct {
    mukca_reach reach;
    double position_before;                /* m: error without correction */
    double position_error, rotation_error; /* m, rad: error with correction */
} mukca_compensation;

/* State of a compensation from row to row.  Do not copy it. */
typedef struct {
    const mukca_corrected *arm;
    mukca_geometry nominal;
    bool position_only; /* implied by fewer than 6 joints */
    /* the preceding row, for paths */
    mukca_row_state rows;
    bool on_path;
    double target[MUKCA_MAX_JOINTS], sent[MUKCA_MAX_JOINTS];
} mukca_compensator;

/* `arm` must outlive it. */
void mukca_compensator_start(mukca_compensator *compensator, const mukca_corrected *arm,
                             bool position_only);

/* Correct q[n_joints], targets in, corrected targets out, with the least change.  `reading` (may be
 * NULL) has time, payload, placement and row number; its angles and commands are ignored.  The move
 * is measured from the last corrected targets.  If the pose is out of reach, q is the closest
 * found. */
mukca_compensation mukca_compensate_joints(double *q, mukca_compensator *compensator,
                                           const mukca_row_reading *reading);

#endif
