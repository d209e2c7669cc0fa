/* The screen of a re-calibration: verdict, the tables of the paper, files written. */
#include <math.h>
#include <string.h>

#include "base/text.h"
#include "cli/recalibrate.h"

static const char *const stage_text[MUKCA_STAGES] = {"before", "angular offsets", "both"};

/* One data set: the paper's position table, then its orientation table. */
static void print_errors(cli_call *call, const char *title, const mukca_pose_errors *e,
                         bool has_angles)
{
    cli_answer(call, "%s (%ld poses)\n", title, e[MUKCA_BEFORE].position.n);
    cli_answer(call,
               "  position, mm         max   mean +- std       |x|    |y|    |z|  removed, %%\n"
               "                                                                 of max, mean\n");
    for (int s = 0; s < MUKCA_STAGES; s++) {
        const mukca_moments *p = &e[s].position;
        if (s == MUKCA_WITH_ANGLES && !has_angles) continue;
        cli_answer(call, "    %-15s %7.3f %6.3f +- %-6.3f %6.3f %6.3f %6.3f", stage_text[s],
                   1e3 * p->max, 1e3 * p->mean, 1e3 * mukca_moments_std(p),
                   1e3 * e[s].position_axis[0].mean, 1e3 * e[s].position_axis[1].mean,
                   1e3 * e[s].position_axis[2].mean);
        if (s != MUKCA_BEFORE)
            cli_answer(call, " %6.1f %6.1f",
                       cli_removed_percent(e[MUKCA_BEFORE].position.max, p->max),
                       cli_removed_percent(e[MUKCA_BEFORE].position.mean, p->mean));
        cli_answer(call, "\n");
    }
    if (e[MUKCA_BEFORE].rotation.n == 0) return;
    cli_answer(call, "  orientation, mrad |ex|: max, mean +- std   |ey|                   |ez|\n");
    for (int s = 0; s < MUKCA_STAGES; s += MUKCA_WITH_BOTH) {
        cli_answer(call, "    %-8s", s == MUKCA_BEFORE ? "before" : "after");
        for (int a = 0; a < 3; a++)
            cli_answer(call, " %6.2f, %5.2f +-%5.2f", 1e3 * e[s].rotation_axis[a].max,
                       1e3 * e[s].rotation_axis[a].mean,
                       1e3 * mukca_moments_std(&e[s].rotation_axis[a]));
        cli_answer(call, "\n");
    }
}

static void print_unknowns(cli_call *call, const mukca_recalibration *f, const mukca_chain *arm)
{
    char text[MUKCA_UNKNOWN_TEXT];
    cli_answer(call, "Offsets (rank %d of %d; *: identifiable only in combination, see --json)\n",
               f->rank, f->n);
    for (int u = 0; u < f->n; u++) {
        mukca_unknown_text(text, &f->unknown[u], arm);
        cli_answer(call, "    %-32s %+9.4f +- %-8.4f %s%s\n", text, 1e3 * f->value[u],
                   1e3 * f->sigma[u], mukca_unknown_is_angle(f->unknown[u].kind) ? "mrad" : "mm",
                   f->identifiable[u] ? "" : " *");
    }
}

/* The largest identifiable offset of each kind: joint zeros, lengths of the arm, tool. */
static void print_largest(cli_call *call, const mukca_recalibration *f, const mukca_chain *arm)
{
    char text[MUKCA_UNKNOWN_TEXT], words[400] = "";
    mukca_text line = MUKCA_TEXT(words);
    for (int kind = 0; kind < 3; kind++) {
        int best = -1;
        for (int u = 0; u < f->n; u++) {
            const mukca_unknown *x = &f->unknown[u];
            const int of = x->tool ? 2 : !mukca_unknown_is_angle(x->kind);
            const bool larger = best < 0 || fabs(f->value[u]) > fabs(f->value[best]);
            if (of == kind && larger && (f->identifiable[u] || x->tool)) best = u;
        }
        if (best < 0) continue;
        mukca_unknown_text(text, &f->unknown[best], arm);
        mukca_text_put(&line, "%s %s %+.3f %s", line.used ? "," : "; largest:", text,
                       1e3 * f->value[best],
                       mukca_unknown_is_angle(f->unknown[best].kind) ? "mrad" : "mm");
    }
    cli_answer_keyed(call, "Offsets", "%d of %d combinations identified%s", f->rank, f->n, words);
}

static void print_findings(cli_call *call, const cli_recalibrated *r, const mukca_acceptance *a)
{
    const mukca_recalibration *f = r->fit;
    cli_answer(call, "%s: %ld measured poses\n", r->arm.robot, f->rows);
    cli_answer_keyed(call, "Result",
                     "the poses contain a calibration: median position error %.4f mm nominal, "
                     "%.4f mm after the fit",
                     1e3 * r->oracle.position_nominal, 1e3 * r->oracle.position_left);
    if (!a->accepted) cli_answer_keyed(call, "Use", "no: %s", a->reason);
    for (int j = 0; j < r->arm.n_joints; j++)
        if (cli_never_moved(f, j))
            cli_answer_wrapped(call,
                               "joint '%s' never moved: its zero offset is not identifiable; it is "
                               "indistinguishable "
                               "from the links before and after it",
                               mukca_chain_joint_name(&r->arm, j));
    if (f->lag_found)
        cli_answer_wrapped(call,
                           "Lag: the joint angles are %.4g %s older than the poses (%.0f standard "
                           "errors); corrected",
                           f->in_rows ? f->lag : 1e3 * f->lag, f->in_rows ? "rows" : "ms",
                           f->lag_score);
}

void cli_recalibrate_print(cli_call *call, const cli_recalibrated *r, const mukca_acceptance *a)
{
    const char *output = call->common->output;
    print_findings(call, r, a);
    print_errors(call, "Training data", r->fit->errors, r->fit->has_angles);
    if (r->tested) print_errors(call, "Test data", r->test, r->fit->has_angles);
    print_largest(call, r->fit, &r->arm);
    if (call->common->verbose) print_unknowns(call, r->fit, &r->arm);
    if (output)
        cli_answer_keyed(call, "Written", "%s%s", output,
                         a->accepted ? "" : " (other commands refuse this table)");
    else if (a->accepted)
        cli_answer_keyed(call, "Next", "-o offsets.tsv saves the result; -v lists all offsets");
}
