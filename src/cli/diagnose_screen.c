/* The screen of a diagnosis: 80 columns, causes first. */
#include <math.h>
#include <string.h>

#include "cli/diagnose.h"
#include "math/stats.h"

#define put mukca_wording_put /* short for this file */

/* Causes, faults and reasons with a separate line, on a screen of some 30 lines. */
enum { MOST_CAUSES = 8, MOST_LINES = 6 };

static void print_more(FILE *stream, int n)
{
    cli_print_keyed(stream, "", put(MUKCA_WORDS, "and %d more; --json lists them all", n));
}

/* ---- causes ---- */

/* " (indistinguishable in these data; 10 more postures would decide: ...)" */
static const char *put_tie(char text[MUKCA_WORDING], const mukca_diagnosed *r, const mukca_cause *c)
{
    const mukca_next_poses *next = r->next;
    if (!c->n_ties && !c->or_unknown) return text;
    put(text, " (indistinguishable in these data%s",
        mukca_next_poses_need_readings(c) ? "; readings would decide" : "");
    if (next && next->cause >= 0 && c == &r->diagnosis->causes[next->cause]) {
        const mukca_plan *plan = &next->plan;
        const int rows =
            plan->evidence_after >= MUKCA_PLAN_NAME ? plan->n_rows : plan->rows_to_name;
        if (rows > 0)
            put(text, "; %d more postures would %s: mukca plan --settle --rows %d", rows,
                c->n_ties + c->or_unknown > 1 ? "separate two of these" : "decide", rows);
        else if (r->data->n_sockets > 0)
            put(text, "; a placement far from these may decide: mukca plan --settle --place");
    }
    return put(text, ")");
}

/* The first cause has its mechanism or tie on a line of its own. */
static void print_cause(FILE *stream, const mukca_diagnosed *r, const mukca_cause *c, int printed)
{
    char text[MUKCA_WORDING] = "";
    mukca_wording_rivals(text, c, r);
    if (printed) {
        put(text, c->n_ties ? "; " : ", ");
    } else {
        if (!c->n_ties && !c->or_unknown) put(text, ": %s", mukca_wording_mechanism(c, r));
        cli_print_keyed(stream, "Cause", put_tie(text, r, c));
        text[0] = '\0';
    }
    put(text, "%s, %s", mukca_wording_amplitude(MUKCA_WORDS, c, r->chain),
        mukca_wording_probability(MUKCA_WORDS, c->probability));
    cli_print_keyed(stream, printed == 1 ? "Also" : "", printed ? put_tie(text, r, c) : text);
}

static void print_causes(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    int printed = d->verdict == MUKCA_VERDICT_UNKNOWN;
    if (printed) cli_print_keyed(stream, "Cause", mukca_wording_unexplained(MUKCA_WORDS, r));
    for (int i = 0; i < d->n_causes; i++) {
        if (!mukca_wording_on_arm(&d->causes[i])) continue;
        if (printed <= MOST_CAUSES) print_cause(stream, r, &d->causes[i], printed);
        printed++;
    }
    if (printed > MOST_CAUSES + 1) print_more(stream, printed - MOST_CAUSES - 1);
    if (!printed)
        cli_print_keyed(stream, "Cause", mukca_wording_verdict(MUKCA_WORDS, r));
    else if (d->verdict != MUKCA_VERDICT_UNKNOWN)
        cli_print_keyed(stream, "Rest",
                        d->unexplained ? "unexplained structure" : "nothing above the noise");
}

/* ---- the recording ---- */

static void print_recording(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    for (int i = 0; i < d->n_faults && i < MOST_LINES; i++)
        cli_print_keyed(stream, i ? "" : "Faults",
                        mukca_wording_fault(MUKCA_WORDS, &d->faults[i], r));
    if (d->n_faults > MOST_LINES) print_more(stream, d->n_faults - MOST_LINES);
    cli_print_keyed(stream, "Efforts", mukca_wording_efforts(MUKCA_WORDS, r));
}

/* ---- held-out errors ---- */

/* "; the causes reduce it by 36 % [30, 41], in 3 of 3 folds" */
static void put_gain(char text[MUKCA_WORDING], const mukca_shrink *s)
{
    if (!isfinite(s->shrink_percent)) return;
    const bool more = s->shrink_percent < 0;
    put(text, "; the causes %s it by %.0f %%", more ? "raise" : "reduce", fabs(s->shrink_percent));
    if (isfinite(s->low_percent) && isfinite(s->high_percent))
        put(text, " [%.0f, %.0f]%s", /* + 0: no -0 */
            rint(more ? -s->high_percent : s->low_percent) + 0,
            rint(more ? -s->low_percent : s->high_percent) + 0,
            s->low_percent > 0 ? "" : ", not significant");
    put(text, ", in %d of %d folds", s->folds_better, s->folds);
}

/* How far the errors can be trusted. */
static void print_trust(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char folds[MUKCA_WORDING] = "";
    if (d->folds > 1) {
        put(folds, "Cross-validated: each %s predicted from the others",
            r->data->n_placements >= 2 ? "placement"
            : r->data->n_sockets > 0   ? "socket"
                                       : "fold of the log");
        if (d->n_causes) put_gain(folds, &d->held_out);
    }
    cli_print_wrapped(stream, folds);
    if (mukca_wording_worse(d))
        fputs("The causes increase the error on the test data: they are uncertain.\n", stream);
    if (r->data->n_sockets == 0 || r->data->n_placements >= 4 || !d->n_causes) return;
    fputs("Fewer than four placements: the reduction by the causes is uncertain.\n", stream);
}

static void print_errors(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    mukca_step steps[MUKCA_MAX_STEPS];
    const int n = mukca_wording_steps(steps, r);
    if (!isfinite(d->nominal_m)) return;
    fprintf(stream, "\n%sMean error, mm%s%26s%s\n", cli_bold(stream), cli_plain(stream),
            d->folds > 1 ? "cross-validated" : "training",
            isfinite(d->test_geometry_m) ? "    test" : "");
    for (const mukca_step *s = steps; s < steps + n; s++) {
        if (!isfinite(s->cross_validated_m)) continue;
        fprintf(stream, "  %-28s %12.3f", s->name, 1e3 * s->cross_validated_m);
        if (isfinite(s->test_m)) fprintf(stream, " %8.3f", 1e3 * s->test_m);
        fputc('\n', stream);
    }
    print_trust(stream, r);
}

/* ---- detection limits ---- */

/* Detection limits, and effects not testable. */
static void print_limits(FILE *stream, const mukca_diagnosed *r)
{
    fputc('\n', stream);
    cli_print_wrapped(stream, mukca_wording_limits(MUKCA_WORDS, r));
    for (int i = 0, lines = 0; i < r->diagnosis->n_tested && lines < MOST_LINES; i++) {
        const char *words = mukca_wording_untestable(MUKCA_WORDS, i, r);
        if (!*words) continue;
        cli_print_wrapped(stream, put(MUKCA_WORDS, "Not testable: %s", words));
        lines++;
    }
    if (!r->data->time)
        fprintf(stream, "joint_drift: no time_s column; %.0f s per sample assumed\n",
                MUKCA_SECONDS_PER_ROW);
}

/* ---- the screen ---- */

/* The most probable sets of causes. */
static void print_sets(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    bool printed[MUKCA_MAX_SETS] = {false};
    double rest = 1;
    if (d->n_sets == 0) return;
    fprintf(stream, "\n%sSets of causes%s by posterior probability\n", cli_bold(stream),
            cli_plain(stream));
    for (int i = 0; i < d->n_sets; i++) { /* sets of the same names are one row */
        const char *row = mukca_wording_set(MUKCA_WORDS, &d->sets[i], r);
        double probability = 0;
        if (printed[i]) continue;
        for (int k = i; k < d->n_sets; k++) {
            if (printed[k] || strcmp(row, mukca_wording_set(MUKCA_WORDS, &d->sets[k], r)) != 0)
                continue;
            printed[k] = true;
            probability += d->sets[k].probability;
        }
        fprintf(stream, "  %5.1f %%  ", 100 * probability);
        cli_print_words(stream, 11, 11, row, strlen(row));
        rest -= probability;
    }
    if (rest > 5e-4) fprintf(stream, "  %5.1f %%  other sets\n", 100 * rest);
}

void cli_diagnosis_print(FILE *stream, const mukca_diagnosed *r, bool sets)
{
    cli_print_head(stream, r->chain->robot, r->data, r->test);
    if (r->acceptance) cli_print_acceptance(stream, r->acceptance, r->chain);
    cli_print_wrapped(stream, mukca_wording_caveat(MUKCA_WORDS, r));
    if (r->diagnosis->verdict == MUKCA_VERDICT_UNTESTABLE) {
        cli_print_wrapped(stream, mukca_wording_verdict(MUKCA_WORDS, r));
        print_recording(stream, r);
        return;
    }
    fputc('\n', stream);
    print_causes(stream, r);
    cli_print_keyed(stream, r->data->n_targets > 1 ? "Targets" : "Logs",
                    mukca_wording_logs(MUKCA_WORDS, r));
    cli_print_keyed(stream, "Angles", mukca_wording_angles(MUKCA_WORDS, r));
    print_recording(stream, r);
    print_errors(stream, r);
    if (r->check) fputc('\n', stream);
    cli_print_keyed(stream, "Check", mukca_wording_check(MUKCA_WORDS, r));
    print_limits(stream, r);
    cli_print_keyed(stream, "Next", mukca_wording_next(MUKCA_WORDS, r));
    if (sets) print_sets(stream, r);
}
