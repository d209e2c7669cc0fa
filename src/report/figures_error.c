/* Figures of the remaining error over the angle of each joint. */
#include <math.h>

#include "base/text.h"
#include "report/report.h"

static const double mm = MUKCA_REPORT_MM;

bool mukca_report_joints(mukca_plot *plot, const void *content, int index)
{
    const mukca_report *r = content;
    if (index >= r->chain->n_joints) return false;
    const int n = r->chain->n_joints, rows = r->train->n_rows;
    const mukca_element *e = &r->chain->element[r->chain->joint_element[index]];
    const bool turns = e->type != MUKCA_PRISMATIC, causes = r->offsets->n_effects > 0;
    const char *coordinate = turns ? "angle" : "position";
    const double unit = turns ? 180 / M_PI : mm;
    mukca_text description = MUKCA_TEXT(plot->words);
    snprintf(plot->id, sizeof plot->id, "joint-%d", index + 1);
    snprintf(plot->title, sizeof plot->title, "Error over the %s of %s", coordinate, e->name);
    snprintf(plot->label[0], sizeof *plot->label, "%s, %s", coordinate, turns ? "deg" : "mm");
    snprintf(plot->label[1], sizeof *plot->label, "error along its motion, mm");
    plot->height = 320;
    plot->brief = true;
    plot->key[MUKCA_PLOT_AFTER] = causes ? "with its causes" : "calibrated";
    plot->key[MUKCA_PLOT_BEFORE] = causes ? "without them" : NULL;
    for (int m = causes ? MUKCA_RIGID : MUKCA_CALIBRATED; m <= MUKCA_CALIBRATED; m++)
        for (int k = index; k < n * rows; k += n) {
            const double point[2] = {r->train->q[k] * unit, r->joint_error[m][k] * mm};
            mukca_plot_add(plot, m == MUKCA_RIGID ? MUKCA_PLOT_BEFORE : MUKCA_PLOT_AFTER, point,
                           NAN, NAN);
        }
    mukca_text_put(&description,
                   "The part of each sample's error along which %s moves the %s, over the joint's "
                   "%s: %.3f mm rms calibrated",
                   e->name, r->train->n_sockets > 0 ? "ball" : "target", coordinate,
                   mukca_report_joint_rms(r, MUKCA_CALIBRATED, index) * mm);
    if (causes)
        mukca_text_put(&description, ", %.3f mm without the causes of the table",
                       mukca_report_joint_rms(r, MUKCA_RIGID, index) * mm);
    mukca_text_put(&description, ".");
    return true;
}
