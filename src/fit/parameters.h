/* Free parameters of the geometry, and those of them that are regularised. */
#ifndef MUKCA_FIT_PARAMETERS_H
#define MUKCA_FIT_PARAMETERS_H

#include "mukca/chain.h"

enum {
    MUKCA_MAX_FREE = MUKCA_PARAMETERS * MUKCA_MAX_ELEMENTS,
    MUKCA_PARAMETER_TEXT = MUKCA_NAME_SIZE + 8 /* "joint.parameter" */
};

/* The user's selection; zeroed: the default set.  A list is comma-separated; an item is
 *     joint              all six parameters of that URDF joint (fixed joints may be named too)
 *     parameter          x y z roll pitch or yaw, of every joint of the default set
 *     joint.parameter    one number
 * A joint with the name of a parameter takes precedence.  `free` replaces the default set; with a
 * leading + it adds to the set.  `freeze` is applied last. */
typedef struct {
    const char *free;    /* NULL: the default set */
    const char *freeze;  /* NULL: nothing */
    bool regularise_tip; /* also regularise the last fixed joint */
} mukca_selection;

typedef struct {
    int n;                                     /* free parameters */
    short index[MUKCA_MAX_FREE];               /* [n] index into theta, ascending */
    unsigned char regularised[MUKCA_MAX_FREE]; /* [n] 1: towards nominal */
} mukca_parameters;

/* The default set: the origins of the actuated joints and of the last fixed joint before the tip
 * (not regularised), as changed by the selection.  Frames that mukca_chain_with_frames added are
 * always in the set unless frozen, never regularised.  Errors: MUKCA_USAGE (unknown name, nothing
 * free). */
mukca_status mukca_parameters_select(mukca_parameters *parameters, const mukca_chain *chain,
                                     const mukca_selection *selection, mukca_error *error);

/* x[n] from theta[6 * n_elements], and back (frozen entries of theta are unchanged). */
void mukca_parameters_pack(double *x, const mukca_parameters *parameters, const double *theta);
void mukca_parameters_unpack(double *theta, const mukca_parameters *parameters, const double *x);

/* Name "joint.parameter" of entry `index` of theta. */
void mukca_parameters_text(char text[MUKCA_PARAMETER_TEXT], const mukca_chain *chain, int index);

/* Element of the last fixed joint before the tip, -1: the last joint is actuated. */
int mukca_chain_tip_element(const mukca_chain *chain);

/* Names of the frames that are fitted for measured poses. */
#define MUKCA_BASE_FRAME "base_frame"
#define MUKCA_TOOL_FRAME "tool_frame"

#endif
