/* Figure of the comparison of two models: distribution of the tip's difference over the
 * workspace. */
#include <math.h>

#include "report/comparison.h"

void mukca_comparison_draw(mukca_plot *plot, const mukca_comparison *c)
{
    static const char *const style[2] = {PLOT_BEFORE " lw 2 title 'as they are'",
                                         PLOT_AFTER " lw 2 dt 2 title 'base and tool aligned'"};
    FILE *s = plot->script;
    for (int aligned = 0; aligned < 2; aligned++) {
        fprintf(s, "$d%d << EOD\n", aligned);
        for (int i = 0; i < MUKCA_COMPARED; i++)
            /* a logarithmic axis has no zero: a hundredth of a micrometre replaces it */
            fprintf(s, "%.6g %.6g\n", 1e3 * fmax(c->error[aligned][i], 1e-8),
                    100.0 * (i + 1) / MUKCA_COMPARED);
        fputs("EOD\n", s);
    }
    mukca_plot_begin(plot, "comparison", "Error of the tip between the two models", MUKCA_PLOT_HALF,
                     360);
    fputs(
        "set logscale x\nset format x '%g'\nset yrange [0:100]\nset xlabel 'error of the tip, mm'\n"
        "set ylabel 'postures with a smaller error, %'\nplot ",
        s);
    for (int aligned = 0; aligned < 2; aligned++)
        fprintf(s, "%s$d%d using 1:2 with lines lc rgb %s", aligned ? ", " : "", aligned,
                style[aligned]);
    fputc('\n', s);
    fprintf(plot->description,
            "Mean error of the tip %.3g mm as they are, %.3g mm with base and tool aligned.",
            1e3 * c->position[0].mean, 1e3 * c->position[1].mean);
}
