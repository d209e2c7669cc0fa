/* Declarations shared by the files of `mukca simulate`. */
#ifndef MUKCA_CLI_SIMULATE_H
#define MUKCA_CLI_SIMULATE_H

#include "cli/cli.h"
#include "simulate/motion.h"
#include "simulate/simulate.h"

/* Syntax of `mukca simulate --effect`: effects of the catalogue and recording faults.
 *
 *     NAME[:WHERE][@VARIANT][=VALUE[,VALUE...]][,NAME...]
 *
 * WHERE is a joint, PLACEMENT, JOINT/PLACEMENT or PLACEMENT/SOCKET, depending on the effect; VALUE
 * is in the catalogue's SI unit.  For an effect with several coefficients, a single VALUE is their
 * magnitude, and the seed determines phase or direction.  Of a moving arm, the effects are those of
 * mukca_simulated_kinds. */

enum { CLI_MAX_SIMULATED_FAULTS = 64, CLI_MAX_SIMULATED_TORQUES = 64 };

/* Names that a specification may refer to, and its results. */
typedef struct {
    const mukca_chain *chain;
    const mukca_place *places;
    int n_places, rows; /* per socket */
    mukca_random random;
    int n_effects, n_faults;
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    mukca_simulated_fault faults[CLI_MAX_SIMULATED_FAULTS];
    bool moves; /* the arm; then `torques` instead of effects and faults */
    int n_torques;
    mukca_simulated_torque torques[CLI_MAX_SIMULATED_TORQUES];
} cli_simulated;

/* Parse `text` and append its effects and faults.  Errors: MUKCA_USAGE. */
mukca_status cli_simulated_parse(cli_simulated *simulated, const char *text, mukca_error *error);

/* Rows of a moving arm, after a header.  Errors: MUKCA_INTERRUPTED. */
mukca_status cli_write_motion(FILE *stream, const mukca_simulated_motion *motion, char separator);

/* Its effects as a table of the columns of `mukca motion -o`. */
void cli_write_torques(FILE *stream, const mukca_simulated_motion *motion);

/* One --place NAME[=X,Y,Z[,ROLL,PITCH,YAW]], of simulate and plan.  Errors: MUKCA_USAGE. */
mukca_status cli_read_place(mukca_place *place, const char *text, mukca_error *error);

#endif
