/* A recording as it would be without what the traits of its model say. */
#ifndef MUKCA_FLEET_CORRECT_H
#define MUKCA_FLEET_CORRECT_H

#include "fleet/traits.h"

/* The means of the elastic traits as effects[MUKCA_FLEET_TERMS]; returns their number.  sigma (may
 * be NULL) gets how far an arm may differ. */
int mukca_traits_effects(mukca_effect *effects, double *sigma, const mukca_traits *traits);

/* Move the recorded angles the least so that the nominal tip goes where the effects displace it, to
 * first order. */
void mukca_traits_correct(mukca_dataset *data, const mukca_chain *chain,
                          const mukca_effect *effects, int n);

#endif
