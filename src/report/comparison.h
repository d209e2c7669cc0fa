/* The figure of two models compared. */
#ifndef MUKCA_REPORT_COMPARISON_H
#define MUKCA_REPORT_COMPARISON_H

#include "arm/compare.h"
#include "report/plot.h"

/* Draw on an open plot which share of the postures has a smaller error of the tip, with and without
 * alignment. */
void mukca_comparison_draw(mukca_plot *plot, const mukca_comparison *comparison);

#endif
