/* Correction of a recording for the traits of its model. */
#ifndef MUKCA_FLEET_CORRECT_H
#define MUKCA_FLEET_CORRECT_H

#include "fleet/fleet.h"

/* The means of the elastic traits as effects[MUKCA_FLEET_TERMS]; returns their number.  sigma (may
 * be NULL): standard deviation of one more arm. */
int mukca_traits_effects(mukca_effect *effects, double *sigma, const mukca_traits *traits);

/* Change the recorded angles minimally to displace the nominal tip as the effects do, to first
 * order. */
void mukca_traits_correct(mukca_dataset *data, const mukca_chain *chain,
                          const mukca_effect *effects, int n);

#endif
