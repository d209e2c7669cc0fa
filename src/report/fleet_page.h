/* The report of a fleet, verdict and outliers first, and its wording, shared with the screen. */
#ifndef MUKCA_REPORT_FLEET_PAGE_H
#define MUKCA_REPORT_FLEET_PAGE_H

#include "fleet/fleet.h"
#include "report/page.h"
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

/* "arm7: joint compliance at joint_4 6.4 times softer than 7 sisters, ..." */
void mukca_wording_fleet_departure(char text[MUKCA_WORDING], const mukca_departure *departure,
                                   const mukca_fleet *fleet);

typedef struct {
    const char *command, *when; /* command of the page; UTC */
    const mukca_fleet *fleet;
    const mukca_fleet_result *result;
} mukca_fleet_page;

/* The page, whose content `fleet` must outlive it. */
mukca_page mukca_fleet_page_of(const mukca_fleet_page *fleet);

#endif
