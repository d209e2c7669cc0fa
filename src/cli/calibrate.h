/* Declarations shared by the files of the calibrate command. */
#ifndef MUKCA_CLI_CALIBRATE_H
#define MUKCA_CLI_CALIBRATE_H

#include "accept/accept.h"
#include "cli/scores.h"

typedef struct {
    cli_common common;
    const char *free, *freeze;
    int solver, gradient;
    double lambda;
    bool regularise_tip;
} calibrate_options;

typedef struct {
    mukca_fit fit;
    double nominal[MUKCA_MAX_THETA]; /* of the chain, free frames aligned to the training data */
    cli_scores scores;
    mukca_offsets offsets;  /* with verdict */
    double traits_evidence; /* log Bayes factor of their means, or of half of them */
    double traits_share;    /* fraction of the means in use, 0 to 1 */
} calibrate_work;

/* Print one screen, the verdict first; returns the exit code. */
mukca_status cli_calibration_print(cli_call *call);

/* Members of mukca.calibrate/1. */
json_t *cli_calibration_json(const cli_call *call);

/* Names of --gradient. */
extern const char *const cli_gradients[];

#endif
