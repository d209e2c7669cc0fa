/* Units in the names of columns. */
#ifndef MUKCA_BASE_UNIT_H
#define MUKCA_BASE_UNIT_H

#ifdef __cplusplus
extern "C" {
#endif

/* Remove a unit at the end of a column's name, such as ` [deg]` or ` (mm)`; returns SI units per
 * unit, 0: none. */
double mukca_unit_take(char *name);

#ifdef __cplusplus
}
#endif
#endif
