/* Link masses from a table: link, mass_kg, com_x_m, com_y_m, com_z_m. */
#ifndef MUKCA_IO_INERTIALS_H
#define MUKCA_IO_INERTIALS_H

#include "mukca/chain.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    char link[MUKCA_NAME_SIZE];
    double kg;
    double com[3]; /* m, in the link's frame */
} mukca_inertial;

/* Read the table into a new list (*list, free it with free) of *n links.  Errors: MUKCA_INPUT (a
 * negative or absurd mass, a link that comes twice), MUKCA_MEMORY. */
mukca_status mukca_inertials_read(mukca_inertial **list, int *n, const char *path,
                                  mukca_error *error);

#ifdef __cplusplus
}
#endif
#endif
