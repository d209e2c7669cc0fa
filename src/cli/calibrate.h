/* What the files of the calibrate command share with report. */
#ifndef MUKCA_CLI_CALIBRATE_H
#define MUKCA_CLI_CALIBRATE_H

#include "cli/scores.h"
#include "fit/fit.h"

typedef struct {
    const mukca_fit *fit;
    const mukca_dataset *train, *test;
    cli_scores train_scores, test_scores;
} calibrate_result;

/* One screen for people, the verdict first. */
void calibrate_print(cli_call *call, const calibrate_result *result);

/* The offsets table of a fit. */
void calibrate_fill_offsets(mukca_offsets *offsets, const mukca_fit *fit);

/* The contract's mukca.calibrate/1. */
json_t *calibrate_json(const calibrate_result *result, const mukca_offsets *offsets,
                       const char *solver, const char *gradient, double elapsed);

#endif
