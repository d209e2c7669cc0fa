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

/* Is `link` a link of that name, with or without a prefix ("left_panda_link1" is a "link1")? */
bool mukca_inertials_names(const char *link, const char *name);

/* Does the file belong to an arm of this geometry?  It does where each row with origin_x_m,
 * origin_y_m, origin_z_m names a link of the chain whose joint is there.  A file without these
 * columns, or that cannot be read, fits nothing. */
bool mukca_inertials_fit(const mukca_chain *chain, const char *path);

/* Read the table into a new list (*list, free it with free) of *n links.  Errors: MUKCA_INPUT (a
 * negative or absurd mass, a link that comes twice), MUKCA_MEMORY. */
mukca_status mukca_inertials_read(mukca_inertial **list, int *n, const char *path,
                                  mukca_error *error);

#ifdef __cplusplus
}
#endif
#endif
