/* Declarations shared by the files of `mukca simulate`. */
#ifndef MUKCA_CLI_SIMULATE_H
#define MUKCA_CLI_SIMULATE_H

#include "cli/cli.h"
#include "simulate/simulate.h"

/* Syntax of `mukca simulate --effect`: effects of the catalogue and recording faults.
 *
 *     NAME[:WHERE][@VARIANT][=VALUE[,VALUE...]][,NAME...]
 *
 * WHERE is a joint, PLACEMENT, JOINT/PLACEMENT or PLACEMENT/SOCKET, depending on the effect; VALUE
 * is in the catalogue's SI unit.  For an effect with several coefficients, a single VALUE is their
 * magnitude, and the seed determines phase or direction. */

enum { CLI_MAX_SIMULATED_FAULTS = 64 };

/* Names that a specification may refer to, and its results. */
typedef struct {
    const mukca_chain *chain;
    const mukca_place *places;
    int n_places, rows; /* per socket */
    mukca_random random;
    int n_effects, n_faults;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    mukca_simulated_fault faults[CLI_MAX_SIMULATED_FAULTS];
} cli_simulated;

/* Parse `text` and append its effects and faults.  Errors: MUKCA_USAGE. */
mukca_status cli_simulated_parse(cli_simulated *simulated, const char *text, mukca_error *error);

enum { CLI_MAX_PLACES = MUKCA_MAX_PLACEMENTS };

/* One --place NAME[=X,Y,Z[,ROLL,PITCH,YAW]], of simulate and plan.  Errors: MUKCA_USAGE. */
mukca_status cli_read_place(mukca_place *place, const char *text, mukca_error *error);

#endif
