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

/* Whether `link` has that name, with or without a prefix ("left_panda_link1" is a "link1"). */
bool mukca_inertials_names(const char *link, const char *name);

/* Whether the file belongs to an arm of this geometry: each row with origin_x_m, origin_y_m,
 * origin_z_m must name a link of the chain whose joint has that origin.  False for a file without
 * these columns or an unreadable one. */
bool mukca_inertials_fit(const mukca_chain *chain, const char *path);

/* Read the table into a new list of *n links; free *list with free.  Errors: MUKCA_INPUT (a
 * negative or implausible mass, a duplicate link), MUKCA_MEMORY. */
mukca_status mukca_inertials_read(mukca_inertial **list, int *n, const char *path,
                                  mukca_error *error);

#ifdef __cplusplus
}
#endif
#endif
