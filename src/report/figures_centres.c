/* Figure of the predicted ball centres: three projections of one placement, of the test data if
 * there are any. */
#include <math.h>

#include "report/parts.h"

/* Print the positions in each socket of a placement relative to `origin`, mm, as blocks
 * $<name><n>. */
static void put_block(FILE *s, const char *name, const double *positions, const double *origin,
                      const mukca_dataset *data, int placement)
{
    for (int k = 0, n = 0; k < data->n_sockets; k++) {
        if (data->sockets[k].placement != placement) continue;
        fprintf(s, "$%s%d << EOD\n", name, n++);
        for (int i = 0; i < data->n_rows; i++)
            if (data->socket[i] == k)
                fprintf(s, "%.4f %.4f %.4f\n", (positions[3 * i] - origin[0]) * MUKCA_REPORT_MM,
                        (positions[3 * i + 1] - origin[1]) * MUKCA_REPORT_MM,
                        (positions[3 * i + 2] - origin[2]) * MUKCA_REPORT_MM);
        fputs("EOD\n", s);
    }
}

/* Mean of the calibrated positions, and the largest coordinate relative to it; returns the number
 * of samples. */
static int measure(double origin[3], double *reach, const mukca_report *r, int placement)
{
    int rows = 0;
    *reach = origin[0] = origin[1] = origin[2] = 0;
    for (int i = 0; i < r->data.n_rows; i++) {
        if (mukca_dataset_placement(&r->data, i) != placement) continue;
        for (int k = 0; k < 3; k++) origin[k] += r->tip[MUKCA_CALIBRATED][3 * i + k];
        rows++;
    }
    for (int k = 0; k < 3 && rows > 0; k++) origin[k] /= rows;
    for (int i = 0; i < r->data.n_rows; i++) {
        if (mukca_dataset_placement(&r->data, i) != placement) continue;
        for (int k = 0; k < 3; k++) {
            *reach = fmax(*reach, fabs(r->tip[MUKCA_CALIBRATED][3 * i + k] - origin[k]));
            *reach = fmax(*reach, fabs(r->tip[MUKCA_NOMINAL][3 * i + k] - origin[k]));
        }
    }
    return rows;
}

bool mukca_report_centres(mukca_plot *plot, const void *content, int index)
{
    const mukca_report *r = content;
    static const char axes[3][3] = {"xy", "xz", "yz"};
    static const int open_point[4] = {6, 8, 4, 12}, full_point[4] = {7, 9, 5, 13};
    const mukca_dataset *data = &r->data;
    char title[160];
    double origin[3], reach;
    if (data->n_sockets == 0 || index > 0) return false;
    const bool test = r->test->n_placements > 0;
    index = test ? r->train->n_placements : 0;
    const int rows = measure(origin, &reach, r, index);
    int sockets = 0;
    for (int k = 0; k < data->n_sockets; k++) sockets += data->sockets[k].placement == index;
    snprintf(title, sizeof title, "Predicted ball centres, placement %s%s",
             data->placements[index].name, test ? " (test)" : "");
    mukca_plot_begin(plot, "centres", title, MUKCA_PLOT_FULL, 370);
    FILE *s = plot->script;
    put_block(s, "b", r->tip[MUKCA_NOMINAL], origin, data, index);
    put_block(s, "a", r->tip[MUKCA_CALIBRATED], origin, data, index);
    fprintf(s,
            "set multiplot layout 1,3 margins 0.07,0.985,0.17,0.9 spacing 0.075\n"
            "reach = %g\nset size ratio -1\nset xrange [-reach:reach]\nset yrange [-reach:reach]\n"
            "set key at graph 0, 1.1\n",
            1.05 * reach * MUKCA_REPORT_MM);
    for (int panel = 0; panel < 3; panel++) {
        const int u = axes[panel][0] - 'x' + 1, v = axes[panel][1] - 'x' + 1;
        fprintf(s, "set xlabel '%c, mm'\nset ylabel '%c, mm' offset 1,0\nplot ", axes[panel][0],
                axes[panel][1]);
        for (int k = 0; k < sockets; k++)
            fprintf(s, "$b%d using %d:%d with points lc rgb " PLOT_BEFORE " pt %d ps 0.7 %s, ", k,
                    u, v, open_point[k % 4], panel == 0 && k == 0 ? "title 'nominal'" : "notitle");
        for (int k = 0; k < sockets; k++)
            fprintf(s, "$a%d using %d:%d with points lc rgb " PLOT_AFTER " pt %d ps 0.6 %s%s", k, u,
                    v, full_point[k % 4], panel == 1 && k == 0 ? "title 'calibrated'" : "notitle",
                    k + 1 < sockets ? ", " : "\n");
    }
    fputs("unset multiplot\n", s);
    fprintf(plot->description,
            "Predicted ball centre of each of %d samples in %d sockets, in the base "
            "frame about the centre of the placement, along z, y and x, at true "
            "scale. Calibration gathers the samples of each socket.",
            rows, sockets);
    return true;
}
