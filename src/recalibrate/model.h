/* Unknowns of re-calibration (the arm's constants, the frames of its poses, a time lag); residual
 * and derivatives of one pose. */
#ifndef MUKCA_RECALIBRATE_MODEL_H
#define MUKCA_RECALIBRATE_MODEL_H

#include "mukca/chain.h"
#include "recalibrate/pose_log.h"

/* kind, name, one letter per axis, whether it is an angle */
#define MUKCA_UNKNOWN_LIST(X)                                                                      \
    X(ZERO, "zero", "", true)              /* added to the encoder angle of a revolute joint */    \
    X(SHIFT, "", "xyz", false)             /* of an element's origin in its parent frame */        \
    X(TILT, "tilt", "12", true)            /* of a revolute joint's axis about a transverse one */ \
    X(BASE_SHIFT, "base", "xyz", false)    /* of the arm's base in the poses' frame */             \
    X(BASE_TURN, "base turn", "xyz", true) /* the same, about the axes of the poses' frame */      \
    X(TOOL_SHIFT, "tool", "xyz", false)    /* of the measured point in the last link */            \
    X(TOOL_TURN, "tool turn", "xyz", true) /* rotation of the measured frame about its own axes */ \
    X(LAG, "lag", "", false)               /* s (or samples): delay of the recorded angles */

typedef enum {
#define MUKCA_UNKNOWN_ENUM(kind, name, axes, angle) MUKCA_UNKNOWN_##kind,
    MUKCA_UNKNOWN_LIST(MUKCA_UNKNOWN_ENUM)
#undef MUKCA_UNKNOWN_ENUM
} mukca_unknown_kind;

typedef struct {
    mukca_unknown_kind kind;
    int element; /* -1: none */
    int axis;    /* 0, 1 or 2; of a tilt 0 or 1 */
    bool tool;   /* of the tool, which has no nominal value */
} mukca_unknown;

enum { MUKCA_MAX_UNKNOWNS = MUKCA_MAX_JOINTS * 6 + 3 + 12 + 1, MUKCA_UNKNOWN_TEXT = 64 + 16 };

/* "joint zero", "joint x", "base turn z", ... */
void mukca_unknown_text(char text[MUKCA_UNKNOWN_TEXT], const mukca_unknown *unknown,
                        const mukca_chain *chain);

/* Whether it is an angle (rad) rather than a length (m). */
bool mukca_unknown_is_angle(mukca_unknown_kind kind);

/* Predicted pose = base * arm(q + zero + lag * velocity) * tool. */
typedef struct {
    mukca_geometry geometry;
    double zero[MUKCA_MAX_JOINTS];
    mukca_frame base, tool;
    double lag;
} mukca_pose_model;

void mukca_pose_model_set(mukca_pose_model *model, const mukca_chain *chain);

/* Add `by` to the value of `unknown`. */
void mukca_pose_model_add(mukca_pose_model *model, const mukca_unknown *unknown, double by);

/* theta[6 * n_elements] with joint zeros expressed as origins; base, tool and lag are ignored. */
void mukca_pose_model_theta(double *theta, const mukca_pose_model *model, const mukca_chain *chain);

/* Frames of one pose, for residual and derivatives. */
typedef struct {
    const mukca_pose_model *model; /* of the caller, as is the row */
    const mukca_pose_row *row;
    mukca_frame before[MUKCA_MAX_ELEMENTS]; /* pose of each element before its joint's rotation */
    mukca_frame flange, tip;                /* last element, without and with the tool */
    double position[3];                     /* measured minus predicted, m; NaN: not measured */
    double rotation[3];                     /* log of predicted' measured, rad; NaN: not measured */
    double rotation_error[3];               /* vector of predicted' measured - I */
} mukca_pose_look;

/* Quaternion order of the log. */
typedef enum { MUKCA_QUATERNION_W_FIRST, MUKCA_QUATERNION_W_LAST } mukca_quaternion_order;

/* The measured orientation; false: none. */
bool mukca_pose_measured(double R[9], const mukca_pose_row *row, mukca_quaternion_order order);

void mukca_pose_look_at(mukca_pose_look *look, const mukca_pose_model *model,
                        const mukca_pose_row *row, mukca_quaternion_order order);

/* Derivatives of the predicted position (3 rows, m) and rotation (3 rows, about the tip's own axes)
 * by each unknown; the rows are `stride` doubles apart.  Either may be NULL. */
void mukca_pose_derivatives(double *position, double *rotation, int stride,
                            const mukca_pose_look *look, const mukca_unknown *unknowns, int n);

#endif
