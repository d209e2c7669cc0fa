/* What separates the measured joint torques of a moving arm from its model: effects, sizes,
 * certainty.
 *
 * Measured torques are linear in the arm's inertial parameters, in its friction and in the
 * coefficients of all effects (effects.h).  Parameters near the model's and the effects have
 * Gaussian priors; the posterior over sets of effects and the findings are those of src/infer. */
#ifndef MUKCA_MOTION_MOTION_H
#define MUKCA_MOTION_MOTION_H

#include "base/text.h"
#include "dynamics/inverse_dynamics.h"
#include "infer/findings.h"
#include "infer/gaussians.h"
#include "motion/effects.h"
#include "mukca/chain.h"

typedef enum { MUKCA_RUN_NEW, MUKCA_RUN_REFERENCE, MUKCA_RUN_TEST } mukca_run_role;

/* A recorded run: angles and measured torques at rising times. */
typedef struct {
    char name[MUKCA_NAME_SIZE];
    mukca_run_role role;
    int n;
    double *time;       /* [n] s */
    double *q, *effort; /* [n][n_joints] rad, N m */
    bool current;       /* motor currents times a gain, uncertain by MUKCA_CURRENT_GAIN */
} mukca_run;

/* Friction and inertia of the drives, about the joint, as the model has them; 0: none. */
typedef struct {
    double coulomb[MUKCA_MAX_JOINTS];  /* N m */
    double viscous[MUKCA_MAX_JOINTS];  /* N m s/rad */
    double armature[MUKCA_MAX_JOINTS]; /* kg m^2 */
} mukca_drives;

/* Called with the fit of parameters and findings, to look at it.  False: no memory. */
struct mukca_torques;
struct mukca_torque_columns;
typedef bool mukca_motion_view(void *context, const struct mukca_torques *torques,
                               const struct mukca_torque_columns *fitted);

typedef struct {
    const mukca_chain *chain;
    mukca_drives drives;
    const mukca_run *run; /* all or none with currents */
    int n_runs;
    bool disabled[MUKCA_MOTION_EFFECTS]; /* effects outside the catalogue of this analysis */
    mukca_motion_view *view;             /* or NULL */
    bool (*progress)(void *context, double share, const char *doing); /* or NULL; false: stop */
    void *progress_context;
    mukca_notes notes;
} mukca_motion_input;

/* Relative uncertainty of a torque constant: the effect of its manufacture, of the temperature of
 * the magnets and of the gear's efficiency (UR10e: 10 % between published sets of gains). */
#define MUKCA_CURRENT_GAIN 0.1

/* Largest part of a joint's range, rms, of a torque that matters to nobody. */
#define MUKCA_MOTION_RELEVANT 0.007

typedef struct {
    int effect; /* -1: outside the catalogue */
    int from, to, detail;
    bool all; /* joints alike: one gain, one delay */
    double probability;
    mukca_estimate amplitude;
    mukca_estimate inertial[MUKCA_INERTIAL]; /* change of the link's parameters; of links */
} mukca_motion_alternative;

enum { MUKCA_MOTION_ALTERNATIVES = 8 };

typedef struct {
    mukca_finding_group group;
    mukca_estimate size_nm;     /* rms torque at the joint with the largest part of its range */
    double size_percent;        /* of that joint's range */
    int worst;                  /* that joint */
    double share;               /* of what all causes explain */
    double before_nm, after_nm; /* held-out error at that joint without and with the finding */
    double outside;             /* part of its probability outside the catalogue */
    int order[2];               /* interval of the orders; 0: none */
    mukca_estimate coefficient;
    int n_alternatives;
    mukca_motion_alternative alternative[MUKCA_MOTION_ALTERNATIVES];
} mukca_motion_finding;

/* Torques of a joint on rows that were not fitted, N m rms. */
typedef struct {
    double nominal_nm;   /* error of the model */
    double baseline_nm;  /* with its parameters fitted */
    double explained_nm; /* with the findings, too */
    double floor_nm;     /* noise */
    double range_nm;     /* largest deviation of the measured torque from its mean */
    bool moves, reverses;
} mukca_motion_joint;

typedef enum {
    MUKCA_MOTION_NONE,
    MUKCA_MOTION_NAMED,
    MUKCA_MOTION_TIED,
    MUKCA_MOTION_UNKNOWN,
    MUKCA_MOTION_VERDICTS
} mukca_motion_verdict;

extern const char *const mukca_motion_verdict_name[MUKCA_MOTION_VERDICTS];

typedef struct {
    mukca_motion_verdict verdict;
    int n_joints, n_runs, n_reference, n_test;
    double seconds; /* of motion, of the new runs */
    double shift_s; /* by which the torques lag behind the angles, in the best set */
    int n_findings, n_maybe;
    mukca_motion_finding finding[MUKCA_MOST_FINDINGS], maybe[MUKCA_MOST_FINDINGS];
    mukca_finding_group group[2 * MUKCA_MOST_FINDINGS]; /* theirs, as they were chosen */
    mukca_motion_joint joint[MUKCA_MAX_JOINTS];
    /* drives and links of the model; fitted within their priors, without effects or reference */
    mukca_drives drives, fitted;
    double inertial[MUKCA_MAX_JOINTS][MUKCA_INERTIAL],
        fitted_inertial[MUKCA_MAX_JOINTS][MUKCA_INERTIAL];
} mukca_motion;

/* Errors: MUKCA_INPUT (the efforts have the wrong sign), MUKCA_UNIDENTIFIABLE (no motion, too
 * little of it, one direction only), MUKCA_INTERRUPTED, MUKCA_MEMORY. */
mukca_status mukca_motion_analyse(mukca_motion *motion, const mukca_motion_input *input,
                                  mukca_error *error);

#endif
