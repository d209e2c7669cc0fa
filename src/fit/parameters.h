/* Free parameters of the geometry, and those of them that are regularised. */
#ifndef MUKCA_FIT_PARAMETERS_H
#define MUKCA_FIT_PARAMETERS_H

#include "mukca/chain.h"

enum { MUKCA_MAX_FREE = MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS };

typedef struct {
    int n;                                     /* free parameters */
    short index[MUKCA_MAX_FREE];               /* [n] index into theta, ascending */
    unsigned char regularised[MUKCA_MAX_FREE]; /* [n] 1: towards nominal */
} mukca_parameters;

/* Is element k in the default set?  It has the origins of the actuated joints, of the last fixed
 * joint before the tip and of added frames. */
bool mukca_parameters_standard(const mukca_chain *chain, int k);

/* The parameters with nonzero mark[6 * n_elements]; NULL: the default set.  Added frames are not
 * regularised, nor is the last fixed joint unless `regularise_tip`. */
void mukca_parameters_set(mukca_parameters *parameters, const mukca_chain *chain,
                          const unsigned char *mark, bool regularise_tip);

/* x[n] from theta[6 * n_elements], and back (frozen entries of theta are unchanged). */
void mukca_parameters_pack(double *x, const mukca_parameters *parameters, const double *theta);
void mukca_parameters_unpack(double *theta, const mukca_parameters *parameters, const double *x);

/* Element of the last fixed joint before the tip, -1: the last joint is actuated. */
int mukca_chain_tip_element(const mukca_chain *chain);

/* Frames added to the chain, to be fitted for measured poses. */
#define MUKCA_BASE_FRAME "base_frame"
#define MUKCA_TOOL_FRAME "tool_frame"
bool mukca_element_is_frame(const mukca_element *element);

#endif
