/* The screen of a diagnosis, 80 columns: use, tip, findings, what remains, the next step; details
 * with -v. */
#include <math.h>

#include "base/text.h"
#include "cli/diagnose.h"

#define put mukca_wording_put /* short for this file */

/* Lines of findings, and of faults and reasons, on a screen of 20 lines. */
enum { MOST_FOUND = 7, MOST_LINES = 3, SIZE_COLUMN = 58 };

/* Least part of the explained error, rms, of a finding that is printed without -v. */
#define RELEVANT 0.05

static void print_more(FILE *stream, int n)
{
    cli_print_keyed(stream, "", put(MUKCA_WORDS, "and %d more; --json lists them all", n));
}

/* ---- findings ---- */

/* The group with its size, and below its certainty and alternatives. */
static void print_finding(FILE *stream, const mukca_diagnosed *r, const mukca_finding *f,
                          const char *key, bool sure)
{
    char text[MUKCA_WORDING] = "", size[48];
    mukca_wording_finding(text, f, r);
    if (!sure) put(text, ", %.0f %%", 100 * f->group.probability);
    snprintf(size, sizeof size, key && sure && *key ? "%.3f of %.3f mm" : "%.3f mm",
             1e3 * f->size_m.value, 1e3 * r->diagnosis->caused_m);
    fprintf(stream, "%s%-8s%s%-*s  %s\n", cli_bold(stream), key, cli_plain(stream), SIZE_COLUMN - 8,
            text, size);
    if (!sure) return;
    cli_print_keyed(stream, "", mukca_wording_certainty(MUKCA_WORDS, f, r));
    cli_print_keyed(stream, "", mukca_wording_alternatives(MUKCA_WORDS, f, r));
}

static void print_findings(FILE *stream, const mukca_diagnosed *r, bool all)
{
    const mukca_diagnosis *d = r->diagnosis;
    int printed = 0, lines = 0;
    for (int i = 0; i < d->n_findings; i++) {
        const bool relevant = d->findings[i].size_m.value > RELEVANT * d->caused_m;
        lines += *mukca_wording_alternatives(MUKCA_WORDS, &d->findings[i], r) ? 3 : 2;
        if (!all && printed && (!relevant || lines > MOST_FOUND)) break;
        print_finding(stream, r, &d->findings[i], printed++ ? "" : "Found", true);
    }
    if (printed < d->n_findings) print_more(stream, d->n_findings - printed);
    if (!printed) cli_print_keyed(stream, "Found", mukca_wording_verdict(MUKCA_WORDS, r));
    for (int i = 0; i < d->n_maybe && (all || i < 1); i++)
        print_finding(stream, r, &d->maybe[i], i ? "" : "Maybe", false);
    cli_print_keyed(stream, "Rest", mukca_wording_rest(MUKCA_WORDS, r));
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

void cli_diagnosis_print(FILE *stream, const mukca_diagnosed *r, bool details)
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
    print_findings(stream, r, details);
    cli_print_keyed(stream, r->data->n_targets > 1 ? "Targets" : "Logs",
                    mukca_wording_logs(MUKCA_WORDS, r));
    cli_print_keyed(stream, "Angles", mukca_wording_angles(MUKCA_WORDS, r));
    print_recording(stream, r);
    if (details) {
        print_errors(stream, r);
        print_limits(stream, r);
    }
    fputc('\n', stream);
    cli_print_keyed(stream, "Next", mukca_wording_next(MUKCA_WORDS, r));
}

/* ---- traits of the fleet ---- */

/* Log Bayes factor of 1 to 20, strong evidence (R. Kass, A. Raftery, J. Am. Stat. Assoc. 90,
 * 1995); weaker evidence is no contradiction. */
#define CONTRADICTION (-3.)

static void put_coefficient(mukca_text *text, const mukca_inherited *c, const mukca_chain *chain)
{
    char words[MUKCA_WORDING];
    const mukca_trait *t = c->trait;
    const double f = 1e6; /* urad per rad */
    mukca_wording_effect(words, t->effect.kind, mukca_chain_joint_name(chain, t->effect.joint));
    mukca_text_put(
        text, "%s, %.3g urad/(N·m) [%.3g, %.3g]; fleet %.3g ± %.2g; %.0f %% from this arm", words,
        f * c->value, f * c->low, f * c->high, f * t->mean, f * t->spread, 100 * c->own_share);
}

void cli_adoption_print(cli_call *call, const mukca_adoption *a, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char line[1024] = "";
    mukca_text text = MUKCA_TEXT(line);
    int shown = 0;
    if (a->traits->n == 0) {
        cli_say(call, "Fleet", "the traits table of %d arms is empty: they share nothing",
                a->traits->n_arms);
        return;
    }
    if (!a->adopted) {
        cli_say(call, "Fleet",
                a->log_evidence < CONTRADICTION
                    ? "the traits of %d arms contradict this arm's data (log Bayes factor %.1f) "
                      "and are not used. Are they of this model, and are the link masses right?"
                    : "the traits of %d arms explain this arm's data less well than its own fit "
                      "(log Bayes factor %.1f) and are not used",
                a->traits->n_arms, a->log_evidence);
        return;
    }
    cli_say(call, "Fleet",
            a->only ? "only the means of %d arms' traits, nothing elastic of this arm (log Bayes "
                      "factor %.1f against its own fit)"
                    : "the traits of %d arms are the prior; this arm's data agree (log Bayes "
                      "factor %.1f against its own fit)",
            a->traits->n_arms, a->log_evidence);
    for (int i = 0; i < a->n; i++) {
        const mukca_inherited *c = &a->list[i];
        if (!(c->trait->probability > 0.5)) continue; /* others only in the JSON */
        put_coefficient(&text, c, r->chain);
        cli_say(call, shown++ ? "" : "Elastic", "%s", line);
        line[text.used = 0] = '\0';
    }
    if (isfinite(d->applied_m))
        cli_say(call, "Error", "held out, with the traits %.3f mm (without %.3f mm)",
                1e3 * d->applied_m, 1e3 * d->explained_m);
    if (isfinite(d->test_geometry_m))
        cli_say(call, "", "test data, with the traits %.3f mm (without %.3f mm)",
                1e3 * d->test_applied_m, 1e3 * d->test_explained_m);
}
