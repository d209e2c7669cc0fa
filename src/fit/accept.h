/* Acceptance of an offsets table, by prediction: the one judgement of all commands. */
#ifndef MUKCA_FIT_ACCEPT_H
#define MUKCA_FIT_ACCEPT_H

#include "arm/tip_change.h"
#include "fit/cross_validation.h"
#include "fit/difference.h"

/* `to` is the table; its verdict has the caller's noise_m, parameters, identified, converged and
 * error_of. */
typedef struct {
    mukca_tip_change_task change; /* the table, the model that it replaces, training samples */
    const mukca_dataset *held;    /* held-out samples; NULL: none are known */
    const double *before, *after; /* [held->n_rows] their errors by both models, m; NaN: none */
    const char *stop;             /* the solver's reason for stopping, or NULL */
    const char *misfit;           /* reason why the samples do not fit the arm, or NULL */
    double training_m; /* mean error of the training samples if `held` are test data, else NaN */
} mukca_accept_task;

/* Judge: the table is accepted if the arm that it describes is better than the one that it replaces
 * by more than its own uncertainty, on held-out samples and at the tip.  Errors: MUKCA_MEMORY. */
mukca_status mukca_accept(mukca_offsets *table, const mukca_accept_task *task, mukca_error *error);

/* Offsets table of a fit, without a verdict. */
void mukca_fit_offsets(mukca_offsets *offsets, const mukca_fit *fit);

/* Held-out errors of two fits to the same data: of fits[0] and, after, of fits[1].  Errors: those
 * of mukca_fit_run. */
mukca_status mukca_fit_compare(mukca_difference *difference, const mukca_fit *const fits[2],
                               const mukca_fit_options options[2], const mukca_chain *chain,
                               const mukca_dataset *data, const mukca_dataset *test,
                               mukca_error *error);

/* Judge the table of a fit to `data`, on `test` (NULL or empty: cross-validation).  Errors: those
 * of mukca_fit_run. */
mukca_status mukca_accept_fit(mukca_offsets *offsets, const mukca_fit *fit,
                              const mukca_chain *chain, const mukca_dataset *data,
                              const mukca_dataset *test, const mukca_fit_options *options,
                              mukca_error *error);

#endif
