/* One more arm with the traits of its model as prior. */
#ifndef MUKCA_FLEET_ADOPT_H
#define MUKCA_FLEET_ADOPT_H

#include "diagnose/diagnose.h"
#include "fleet/fleet.h"

/* ---- correction of a recording for the traits of its model ---- */

/* The means of the elastic traits as effects[MUKCA_FLEET_TERMS]; returns their number.  sigma (may
 * be NULL): standard deviation of one more arm. */
int mukca_traits_effects(mukca_effect *effects, double *sigma, const mukca_traits *traits);

/* Change the recorded angles minimally to displace the nominal tip as the effects do, to first
 * order. */
void mukca_traits_correct(mukca_dataset *data, const mukca_chain *chain,
                          const mukca_effect *effects, int n);

/* A coefficient of this arm, rad/(N m). */
typedef struct {
    const mukca_trait *trait;
    double value, low, high; /* with the fleet as prior; 95 % */
    double own;              /* share of its information from this arm's data, 0 .. 1 */
} mukca_inherited;

typedef struct {
    const mukca_traits *traits;
    bool only;           /* only the traits' means, no elasticity fitted to this arm */
    bool adopted;        /* the traits' prior is in use; else the arm's own fit is better */
    double log_evidence; /* of the traits against the better of the fits without them */
    /* held-out errors with and without the traits, m; NaN: not measured */
    double explained_m, test_explained_m, own_explained_m, own_test_explained_m;
    int n;
    mukca_inherited list[MUKCA_MAX_TRAITS];
} mukca_adoption;

typedef struct {
    const mukca_traits *traits;
    const mukca_dataset *test; /* held-out data, or NULL */
    bool only, folds, applied;
} mukca_adopt_options;

/* Fit the arm with the traits as prior, in the regression of its diagnosis.  If the evidence
 * favours the traits, the diagnosis gets the errors and the applicable effects of that fit;
 * otherwise the regression is restored.  Causes and verdict remain those of the arm's own data.
 * Errors: MUKCA_MEMORY. */
mukca_status mukca_adopt(mukca_adoption *adoption, mukca_regression *m, mukca_diagnosis *diagnosis,
                         const mukca_adopt_options *options, mukca_error *error);

#endif
