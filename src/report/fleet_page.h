/* The report of a fleet: one self-contained HTML page, verdict and outliers first. */
#ifndef MUKCA_REPORT_FLEET_PAGE_H
#define MUKCA_REPORT_FLEET_PAGE_H

#include "fleet/traits.h"
#include "report/plot.h"

typedef struct {
    /* Set by the caller, who owns the memory. */
    const char *command, *when; /* command of the page; UTC */
    const mukca_fleet *fleet;
    const mukca_fleet_result *result;
    /* Set by mukca_fleet_page_prepare. */
    mukca_departure *arms;         /* [n_arms]: most probable departure first */
    int n_departing;               /* number of departing arms, at the start of `arms` */
    int panels[MUKCA_FLEET_TERMS]; /* coefficients: of departing arms first, then shared ones */
} mukca_fleet_page;

/* Sort arms and coefficients for the page.  Free with mukca_fleet_page_free.  Errors:
 * MUKCA_MEMORY. */
mukca_status mukca_fleet_page_prepare(mukca_fleet_page *page, mukca_error *error);
void mukca_fleet_page_free(mukca_fleet_page *page);

/* Write the page.  Errors: those of mukca_plot_svg. */
mukca_status mukca_fleet_page_write(FILE *out, const mukca_fleet_page *page, mukca_error *error);

/* Write each figure as DIRECTORY/<id>.<format>, format "png", "pdf" or "svg".  Errors: as above. */
mukca_status mukca_fleet_page_write_figures(const char *directory, const char *format,
                                            const mukca_fleet_page *page, mukca_error *error);

/* Draw the figure of panel or joint `index` on an open plot; false: there is none
 * (figures_fleet.c). */
typedef bool mukca_fleet_figure(mukca_plot *plot, const mukca_fleet_page *page, int index);
mukca_fleet_figure mukca_fleet_draw_coefficient; /* coefficients of the arms side by side */
mukca_fleet_figure mukca_fleet_draw_orders;      /* pooled ripple spectrum of a joint */

#endif
