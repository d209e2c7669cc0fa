/* Figure of the comparison of two models. */
#ifndef MUKCA_REPORT_COMPARISON_H
#define MUKCA_REPORT_COMPARISON_H

#include "arm/compare.h"
#include "report/plot.h"

/* Draw the cumulative distribution of the tip's difference over the postures, with and without
 * alignment, on an open plot. */
void mukca_comparison_draw(mukca_plot *plot, const mukca_comparison *comparison);

#endif
