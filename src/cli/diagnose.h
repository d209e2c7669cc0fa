/* What the diagnose command's files share, and what serve and report print of a diagnosis. */
#ifndef MUKCA_CLI_DIAGNOSE_H
#define MUKCA_CLI_DIAGNOSE_H

#include "cli/cli.h"
#include "study/diagnose.h"

/* The contract's mukca.diagnose/1 object; `test` may be NULL. */
json_t *cli_diagnosis_json(const mukca_diagnosis *diagnosis, const mukca_chain *chain,
                           const mukca_dataset *data, const mukca_dataset *test);

#endif
