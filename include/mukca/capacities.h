/* Capacities of the structures, which the caller owns.
 *
 * A controller with little memory may use smaller ones; compile the library and the program with
 * the same values: -DMUKCA_MAX_ELEMENTS=12 (docs/realtime.md).  The names of all functions with
 * such structures then contain the capacities: with others than the library's a program does not
 * link.  tests/capacities.sh compares this list with the headers. */
#ifndef MUKCA_CAPACITIES_H
#define MUKCA_CAPACITIES_H

#ifndef MUKCA_MAX_ELEMENTS
#define MUKCA_MAX_ELEMENTS 48
#endif
#ifndef MUKCA_MAX_JOINTS
#define MUKCA_MAX_JOINTS 16
#endif
#ifndef MUKCA_MAX_MASSES
#define MUKCA_MAX_MASSES 96
#endif
#ifndef MUKCA_MAX_EFFECTS
#define MUKCA_MAX_EFFECTS 48
#endif

#if MUKCA_MAX_ELEMENTS != 48 || MUKCA_MAX_JOINTS != 16 || MUKCA_MAX_MASSES != 96 || \
    MUKCA_MAX_EFFECTS != 48
#define MUKCA_OTHER_CAPACITIES
#include "mukca/capacities_names.h"
#endif

#endif
