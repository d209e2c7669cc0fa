/* The screen of a diagnosis: the recording and its detection limits. */
#include <math.h>

#include "base/text.h"
#include "cli/diagnose.h"
#include "math/stats.h"

/* MOST_LINES: faults and reasons with a separate line, on a screen of some 30 lines. */
enum { MOST_LINES = 6, TEXT = 2 * MUKCA_WORDING };

/* A joint whose effects must be larger than this to be detected (rad rms, 1.7 degrees) counts as
 * not testable: no cause of a calibrated arm is that large. */
static const double useless_limit = 30e-3;

/* The other stream of angles is recommended if its residual is below this fraction: effects of the
 * arm account for less than a fifth. */
static const double worth_changing = 0.8;

/* ---- the recording ---- */

void cli_screen_recording(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char line[TEXT] = "";
    for (int i = 0; i < d->n_faults && i < MOST_LINES; i++) {
        mukca_wording_fault(line, &d->faults[i], r);
        cli_print_keyed(stream, i ? "" : "Faults", line);
    }
    if (d->n_faults > MOST_LINES) cli_print_more(stream, d->n_faults - MOST_LINES);
    if (r->data->n_sockets == 0 && d->nominal_m < CLI_ECHO)
        cli_print_keyed(stream, "Poses",
                        "the measured poses repeat the nominal model: they seem to come from the "
                        "controller, not from a tracker, and contain no error of the arm");
    if (!(d->efforts_correlation < 0.5)) return;
    line[0] = '\0';
    mukca_text text = MUKCA_TEXT(line);
    const bool opposed = d->efforts_correlation < -0.5;
    mukca_text_put(&text,
                   "measured efforts %s the torques that hold the arm (correlation %.2f) and were "
                   "not used; %s",
                   opposed ? "oppose" : "differ from", d->efforts_correlation,
                   opposed ? "write them as the torque that the joint exerts on the arm"
                           : "check their unit (N·m), their joints and the masses");
    cli_print_text(stream, "Efforts", &text);
}

/* ---- detection limits ---- */

/* Median of the detection limits of a joint's effects, rad; NaN: none. */
static double joint_limit(const mukca_diagnosis *d, int joint)
{
    double limit[MUKCA_EFFECT_COUNT] = {0};
    int n = 0;
    for (int i = 0; i < d->n_tested && n < MUKCA_EFFECT_COUNT; i++)
        if (d->tested[i].joint == joint && isfinite(d->tested[i].limit))
            limit[n++] = d->tested[i].limit;
    return n ? mukca_stats_median(limit, n) : (double)NAN;
}

void cli_screen_limits(FILE *stream, const mukca_diagnosed *r, bool caveat)
{
    const mukca_diagnosis *d = r->diagnosis;
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    fputc('\n', stream);
    for (int j = 0, n = 0; j < r->chain->n_joints; j++) {
        const double limit = joint_limit(d, j);
        if (!(limit < useless_limit)) continue;
        mukca_text_put(&text, "%s %s %.*f%s",
                       n++ ? "," : "Detection limits, mrad rms (median over effects):",
                       mukca_chain_joint_name(r->chain, j), limit < 1e-5 ? 4 : 2, 1e3 * limit,
                       mukca_wording_slides(r->chain, j) ? " mm" : "");
    }
    cli_print_text(stream, NULL, &text);
    for (int i = 0, lines = 0; i < d->n_tested && lines < MOST_LINES; i++) {
        char words[MUKCA_WORDING];
        if (!mukca_wording_untestable(words, i, r, caveat)) continue;
        mukca_text_put(&text, "Not testable: %s", words);
        cli_print_text(stream, NULL, &text);
        lines++;
    }
    if (!r->data->time)
        fprintf(stream, "joint_drift: no time_s column; %.0f s per sample assumed\n",
                MUKCA_SECONDS_PER_ROW);
}

/* Both streams of angles: their differences, and the one that was fitted. */
void cli_screen_streams(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_streams *s = &r->diagnosis->streams;
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    int largest = 0, n = 0;
    for (int j = 1; j < s->n_joints; j++)
        if (s->joint[j].rms > s->joint[largest].rms) largest = j;
    if (s->n_joints == 0 || !(s->joint[largest].rms > 0)) return;
    mukca_text_put(&text, "%s fitted; reading minus command: at most %.3f mrad rms (%s)",
                   r->data->by_command ? "commands" : "readings", 1e3 * s->joint[largest].rms,
                   mukca_chain_joint_name(r->chain, largest));
    for (int j = 0; j < s->n_joints; j++)
        if (s->joint[j].log_bayes_factor > MUKCA_SAG_EVIDENT && s->joint[j].sag > 0)
            mukca_text_put(&text, "%s %s %.3g urad/(N·m) [%.3g, %.3g]", n++ ? "," : "; servo sag",
                           mukca_chain_joint_name(r->chain, j), 1e6 * s->joint[j].sag,
                           1e6 * s->joint[j].low, 1e6 * s->joint[j].high);
    if (isfinite(s->sigma_command_m))
        mukca_text_put(&text,
                       "; residual of the geometry: %.3f mm with readings, %.3f mm with commands",
                       1e3 * s->sigma_reading_m, 1e3 * s->sigma_command_m);
    const double ratio = s->sigma_command_m / s->sigma_reading_m;
    if (r->data->by_command ? ratio > 1 / worth_changing : ratio < worth_changing)
        mukca_text_put(&text, ": fit the %s (--angles %s)",
                       r->data->by_command ? "readings" : "commands",
                       r->data->by_command ? "reading" : "command");
    cli_print_text(stream, "Angles", &text);
}

/* Several pose logs: free frames that they share; several targets. */
void cli_screen_logs(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_logs *logs = &r->diagnosis->logs;
    const double *evidence = logs->log_evidence;
    const bool targets = r->data->n_targets > 1;
    if (logs->n < 2 || !(targets || isfinite(evidence[1]) || isfinite(evidence[2]))) return;
    const int chosen = logs->base_per_log + 2 * logs->tool_per_log;
    static const char *const own[] = {"", "a tracker's frame", "a target's offset",
                                      "a tracker's frame and a target's offset"};
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    if (targets)
        mukca_text_put(&text, "each of the %d targets has its own position on the tool", logs->n);
    else if (chosen)
        mukca_text_put(&text, "each of the %d pose logs has %s of its own (log Bayes factor %.3g)",
                       logs->n, own[chosen], evidence[chosen] - evidence[0]);
    else
        mukca_text_put(&text, "the %d pose logs share the free frames", logs->n);
    cli_print_text(stream, targets ? "Targets" : "Logs", &text);
}
