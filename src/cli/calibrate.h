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
    bool regularise_tip, evidence;
} calibrate_options;

/* The call's work. */
typedef struct {
    mukca_fit fit, other;            /* the other one: by the evidence */
    double nominal[MUKCA_MAX_THETA]; /* of the chain, free frames aligned to the training data */
    cli_scores scores;
    mukca_cross_validation held;
    mukca_offsets offsets;     /* with verdict */
    mukca_difference evidence; /* from this geometry to that by the evidence; 0 postures: none */
} calibrate_work;

/* Print one screen, the verdict first; returns the exit code. */
mukca_status calibrate_print(cli_call *call);

/* Members of mukca.calibrate/1. */
json_t *calibrate_json(const cli_call *call);

/* Names of --solver and --gradient. */
extern const char *const calibrate_gradients[];

#endif
