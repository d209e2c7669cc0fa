/* Scores of a model on data, nominal and calibrated, as printed by calibrate and evaluate. */
#ifndef MUKCA_CLI_SCORES_H
#define MUKCA_CLI_SCORES_H

#include "cli/cli.h"
#include "fit/evaluate.h"

enum { CLI_NOMINAL, CLI_CALIBRATED, CLI_FACTORY, CLI_MODELS }; /* the last only by --kinematics */

/* Of one of the session's datasets. */
typedef struct {
    const char *name; /* "data", "test" */
    const mukca_dataset *data;
    int n;                          /* placements with samples, plus one for poses or one per log */
    mukca_score *score[CLI_MODELS]; /* [n] each */
    mukca_score mean[CLI_MODELS];
} cli_scored;

typedef struct {
    const double *nominal_theta; /* input: [6 * n_elements] of the nominal model with its free
                                    frames aligned; NULL: the chain's */
    bool by_log;                 /* input: one score for each of several pose logs */
    bool calibrated;             /* input: print the calibrated model, too */
    bool has_factory;            /* --kinematics: nominal is the URDF, factory the file's origins */
    cli_scored set[2];           /* data, and test data (n is 0: none) */
} cli_scores;

/* Score the session's data, under this `name`, and test data at the chain's nominal parameters and
 * at those of `offsets` with its effects.  Errors: MUKCA_MEMORY. */
mukca_status cli_scores_make(cli_call *call, cli_scores *scores, const mukca_chain *chain,
                             const mukca_offsets *offsets, const char *name);

/* JSON array with one object per placement. */
json_t *cli_scores_json(const cli_scored *set, bool factory);

/* The table of evaluate: one row per placement. */
void cli_scores_write(FILE *stream, const cli_scores *scores);

/* Print lines of the screen: "  consistency mm, train        8.278        0.168     -97.97 %", also
 * distortion and rotation if available.  `rows`: also the mean error of each placement or log, mm,
 * if there are several. */
void cli_scores_print(cli_call *call, const cli_scores *scores, bool rows);

/* For data that do not fit the arm: print the mix-up of joint columns or of the base's frame that
 * explains it, if any. */
void cli_print_mismatch(cli_call *call, const mukca_dataset *data, bool free_base, bool free_tool);

#endif
