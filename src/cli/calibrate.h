/* Declarations shared by the files of the calibrate command. */
#ifndef MUKCA_CLI_CALIBRATE_H
#define MUKCA_CLI_CALIBRATE_H

#include "cli/scores.h"
#include "fit/accept.h"
#include "fleet/fleet.h"

typedef struct {
    const mukca_fit *fit;
    const mukca_dataset *train, *test;
    cli_scores scores;
    mukca_offsets *offsets;     /* with verdict */
    const mukca_traits *traits; /* NULL: none given */
    double traits_evidence;     /* log Bayes factor of their means, or of half of them */
    mukca_difference evidence;  /* from this geometry to that by the evidence; 0 postures: none */
    double traits_share;        /* fraction of the means in use, 0 to 1 */
} calibrate_result;

/* Fit again with the means of the traits, and with half of them; keep the fraction with the
 * strongest evidence in the residuals, and correct the data by it.  The offsets table then includes
 * these effects: the geometry is valid only with them. */
mukca_status calibrate_use_traits(cli_call *call, calibrate_result *result, mukca_fit *fit,
                                  const mukca_traits *traits, const mukca_fit_options *options);
void calibrate_add_traits(mukca_offsets *offsets, const calibrate_result *result);
void calibrate_print_traits(cli_call *call, const calibrate_result *result);

/* Print one screen, the verdict first. */
void calibrate_print(cli_call *call, const calibrate_result *result);

/* The members of mukca.calibrate/1. */
json_t *calibrate_json(const calibrate_result *result, const char *solver, const char *gradient,
                       double elapsed);

#endif
