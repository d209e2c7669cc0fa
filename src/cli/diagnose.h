/* What the diagnose command's files share, and what serve and report print of a diagnosis. */
#ifndef MUKCA_CLI_DIAGNOSE_H
#define MUKCA_CLI_DIAGNOSE_H

#include "cli/cli.h"
#include "report/wording.h"

/* The contract's mukca.diagnose/1 object. */
json_t *cli_diagnosis_json(const mukca_diagnosed *result);

/* One screen of 80 columns for people, causes first. */
void cli_diagnosis_print(FILE *stream, const mukca_diagnosed *result);

/* Frames of measured poses that were fitted. */
typedef struct {
    bool base, tool;
} cli_frames;

/* The offsets table: geometry with its standard errors, the causes that act on the arm, the
 * verdict. `chain` gets the chain that the table's rows belong to: the arm's, with the tracker's
 * frame before it where that was fitted.  *left_out counts causes that need masses where the arm
 * has none. Errors: MUKCA_UNIDENTIFIABLE (nothing was fitted), MUKCA_INPUT. */
mukca_status cli_diagnosis_offsets(mukca_offsets *offsets, mukca_chain *chain, int *left_out,
                                   const mukca_diagnosed *result, const cli_frames *frames,
                                   mukca_error *error);

#endif
