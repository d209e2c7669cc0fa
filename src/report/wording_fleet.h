/* The wording of a fleet, shared by screen and page. */
#ifndef MUKCA_REPORT_WORDING_FLEET_H
#define MUKCA_REPORT_WORDING_FLEET_H

#include "fleet/traits.h"
#include "report/wording.h"

/* Unit of all coefficients of a fleet, and their factor from rad/(N m). */
#define MUKCA_WORDING_SPRING "urad/(N·m)"
#define MUKCA_WORDING_PER_SPRING 1e6

/* "joint compliance at joint_4". */
void mukca_wording_fleet_effect(char text[MUKCA_WORDING], const mukca_effect *effect,
                                const mukca_fleet *fleet);

/* A shared coefficient with interval, spread and probability, or a shared order; no full stop. */
void mukca_wording_fleet_trait(char text[MUKCA_WORDING], const mukca_trait *trait,
                               const mukca_fleet *fleet);

/* "joint compliance at joint_4 6.4 times softer than 7 sisters, ...", without the arm's name. */
void mukca_wording_fleet_departure(char text[MUKCA_WORDING], const mukca_departure *departure,
                                   const mukca_fleet *fleet);

#endif
