/* The user's lists of free and frozen parameters. */
#ifndef MUKCA_FIT_SELECTION_H
#define MUKCA_FIT_SELECTION_H

#include "fit/parameters.h"

enum { MUKCA_PARAMETER_TEXT = MUKCA_NAME_SIZE + 8 /* "joint.parameter" */ };

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

/* The default set (parameters.h) as changed by the selection; added frames are always in the set
 * unless frozen.  Errors: MUKCA_USAGE (unknown name, nothing free). */
mukca_status mukca_parameters_select(mukca_parameters *parameters, const mukca_chain *chain,
                                     const mukca_selection *selection, mukca_error *error);

/* Name "joint.parameter" of entry `index` of theta. */
void mukca_parameters_text(char text[MUKCA_PARAMETER_TEXT], const mukca_chain *chain, int index);

#endif
