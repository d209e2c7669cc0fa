/* Acceptance of an offsets table, by prediction: the one judgement of all commands. */
#ifndef MUKCA_ACCEPT_ACCEPT_H
#define MUKCA_ACCEPT_ACCEPT_H

#include "arm/tip_change.h"
#include "fit/evaluate.h"

/* ---- difference of the errors of two models on the same samples (accept.c) ---- */

typedef struct {
    int postures;             /* different ones; a repeated one counts once */
    double before_m, after_m; /* mean errors */
    double mean_m, sigma_m;   /* of after - before, and its standard error */
} mukca_difference;

/* Compare before[n_rows] and after[n_rows], m; NaN: not measured.  Errors: MUKCA_MEMORY. */
mukca_status mukca_difference_find(mukca_difference *difference, const double *before,
                                   const double *after, const mukca_dataset *data,
                                   mukca_error *error);

/* Whether data contradict those of a fit: its error on them is a multiple of the expected one and
 * most of that of the nominal model. */
bool mukca_data_contradict(double error_m, double expected_m, double nominal_m);

/* ---- held-out errors: test data, or each fold predicted by a fit to the others
 * (cross_validation.c) ---- */

typedef struct {
    const mukca_dataset *held; /* in: test data, or NULL; out: test data, else `data` */
    int folds;                 /* 0: test data; or too few samples, nothing is predicted */
    bool placements;           /* folds are placements; else blocks of consecutive samples */
    mukca_dataset data;        /* the samples, or a part of a long recording */
    double *before, *after;    /* [held->n_rows] errors by the nominal model, with the free frames
                                  aligned, and by the fit, m; NaN: not measured */
    mukca_pool pool;
} mukca_cross_validation;

/* Errors of a fit to `data` on result->held; if it is NULL or empty, of fits by Gauss-Newton to
 * parts of the data.  Do not copy the result.  Errors: those of mukca_fit_run. */
mukca_status mukca_fit_cross_validate(mukca_cross_validation *result, const mukca_fit *fit,
                                      const mukca_chain *chain, const mukca_dataset *data,
                                      const mukca_fit_options *options, mukca_error *error);
void mukca_cross_validation_free(mukca_cross_validation *result);

/* ---- expected error of the tip: the posterior of an offsets table, and of the model that it
 * replaces, given samples (tip_error.c) ---- */

/* Postures of the prediction: joint ranges of the samples, joint limits. */
enum { MUKCA_HERE, MUKCA_ELSEWHERE, MUKCA_RANGES };

typedef struct {
    int postures;                                         /* different ones among the samples */
    unsigned char at_rest[MUKCA_MAX_JOINTS];              /* 1: the joint did not move */
    unsigned char stuck[MUKCA_MAX_JOINTS];                /* 1: nor did it, but the tip did */
    double before_m[MUKCA_RANGES], after_m[MUKCA_RANGES]; /* mean error of the tip */
    double scatter_m[MUKCA_RANGES]; /* standard error of after_m by the choice of the postures */
    double low_m[MUKCA_RANGES], high_m[MUKCA_RANGES]; /* 95 % interval of after_m */
    double probability[MUKCA_RANGES]; /* that the table's mean error is the smaller one; HERE: if
                                         the distances are as stated */
    double exact_m;    /* after_m[MUKCA_HERE] if the sockets' distances were as stated, and */
    double distance_m; /* the part of it by them; NaN: none */
    double lacking_m;  /* part of after_m[MUKCA_HERE] by effects that the table lacks; NaN: none */
    int outliers, gross; /* postures that deviate from a robust fit, those by more than any arm */
    char rows[64];       /* of the former: "3, 7, 12", with the file if there are several */
    double worst_m;      /* the largest of these deviations */
    double tool_m;       /* displacement of the tip on its link, from the nominal one */
} mukca_tip_error;

/* Fit geometry and effects to task->data by Gauss-Newton, with the priors of posterior.h in a
 * scale chosen by the data, heavy-tailed noise, and readings of one posture as one sample; then
 * draw arms from the posterior.  The frames of the measurement are unknown, for each file and
 * target of several.  Long recordings are thinned.  Errors: MUKCA_MEMORY. */
mukca_status mukca_tip_error_expect(mukca_tip_error *expected, const mukca_tip_change_task *task,
                                    mukca_error *error);

/* ---- the verdict ---- */

/* Whether measured poses are the controller's own: its forward kinematics, not measurements.
 * `nominal_m` is the mean error of the model without a fit, in free frames. */
bool mukca_poses_repeat(const mukca_dataset *data, double nominal_m);

/* `to` is the table; its verdict has the caller's noise_m, parameters, identified, converged and
 * error_of. */
typedef struct {
    mukca_tip_change_task change; /* the table, the model that it replaces, training samples */
    const mukca_dataset *held;    /* held-out samples; NULL: none are known */
    const double *before, *after; /* [held->n_rows] their errors by both models, m; NaN: none */
    double turn_rad;    /* error of the measured orientations, of `data` without them; 0: none */
    const char *stop;   /* the solver's reason for stopping, or NULL */
    const char *misfit; /* reason why the samples do not fit the arm, or NULL */
    double training_m;  /* mean error of the training samples if `held` are test data, else NaN */
} mukca_accept_task;

/* Judge: the table is accepted if the arm that it describes is better than the one that it replaces
 * by more than its own uncertainty, on held-out samples and at the tip.  Errors: MUKCA_MEMORY. */
mukca_status mukca_accept(mukca_offsets *table, const mukca_accept_task *task, mukca_error *error);

/* Offsets table of a fit, without a verdict. */
void mukca_fit_offsets(mukca_offsets *offsets, const mukca_fit *fit);

/* Judge the table of a fit to `data` by its held-out errors.  Errors: MUKCA_MEMORY. */
mukca_status mukca_accept_fit(mukca_offsets *offsets, const mukca_fit *fit,
                              const mukca_cross_validation *held, const mukca_dataset *data,
                              const mukca_fit_options *options, mukca_error *error);

#endif
