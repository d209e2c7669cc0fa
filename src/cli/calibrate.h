/* What the files of the calibrate command share. */
#ifndef MUKCA_CLI_CALIBRATE_H
#define MUKCA_CLI_CALIBRATE_H

#include "cli/scores.h"
#include "fit/accept.h"
#include "fleet/traits.h"

typedef struct {
    const mukca_fit *fit;
    const mukca_dataset *train, *test;
    cli_scores train_scores, test_scores;
    mukca_offsets *offsets;     /* judged */
    const mukca_traits *traits; /* NULL: none given */
    double traits_evidence;     /* log Bayes factor of their means, or of half of them ... */
    double traits_share;        /* ... of which this share is used, 0 to 1 */
} calibrate_result;

/* The frames of measured poses that were fitted: the arm's base in the frame of the tracker (or of
 * a fixed board), and the target (or camera) in the link that carries it.  False: not fitted. */
bool calibrate_frame(mukca_frame *T, const calibrate_result *result, bool base);

/* Fit again with the means of the traits, and with half of them.  The share for which the evidence
 * of the residuals is strongest is used, in the data, too.  Then its effects belong to the table:
 * without them the geometry does not fit the arm. */
mukca_status calibrate_use_traits(cli_call *call, calibrate_result *result, mukca_fit *fit,
                                  const mukca_traits *traits, const mukca_fit_options *options);
void calibrate_add_traits(mukca_offsets *offsets, const calibrate_result *result);
void calibrate_print_traits(cli_call *call, const calibrate_result *result);

/* One screen for people, the verdict first. */
void calibrate_print(cli_call *call, const calibrate_result *result);

/* The contract's mukca.calibrate/1. */
json_t *calibrate_json(const calibrate_result *result, const char *solver, const char *gradient,
                       double elapsed);

#endif
