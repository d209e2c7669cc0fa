/* Syntax of `mukca simulate --effect`: effects of the catalogue and recording faults.
 *
 *     NAME[:WHERE][@VARIANT][=VALUE[,VALUE...]][,NAME...]
 *
 * WHERE is a joint, PLACEMENT, JOINT/PLACEMENT or PLACEMENT/SOCKET, as the effect needs it; VALUE
 * is in the catalogue's SI unit.  Where an effect has several coefficients, one VALUE is their size
 * and the seed picks the phase or direction.
 */
#ifndef MUKCA_CLI_SIMULATE_SPEC_H
#define MUKCA_CLI_SIMULATE_SPEC_H

#include "cli/cli.h"
#include "simulate/simulate.h"

enum { CLI_MAX_SIMULATED_FAULTS = 64 };

/* What a specification may refer to, and what it drew. */
typedef struct {
    const mukca_chain *chain;
    const mukca_place *places;
    int n_places, rows; /* per socket */
    mukca_random random;
    int n_effects, n_faults;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    mukca_simulated_fault faults[CLI_MAX_SIMULATED_FAULTS];
} cli_simulated;

/* Append what `text` says.  Errors: MUKCA_USAGE. */
mukca_status cli_simulated_parse(cli_simulated *simulated, const char *text, mukca_error *error);

#endif
