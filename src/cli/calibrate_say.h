/* What calibrate says to people: one screen, results first. */
#ifndef MUKCA_CLI_CALIBRATE_SAY_H
#define MUKCA_CLI_CALIBRATE_SAY_H

#include "cli/scores.h"
#include "fit/fit.h"

typedef struct {
    const mukca_fit *fit;
    const mukca_dataset *train, *test;
    cli_scores train_scores, test_scores;
} calibrate_result;

void calibrate_say(cli_call *call, const calibrate_result *result);

#endif
