/* The screen of a diagnosis: 80 columns, causes first. */
#include <math.h>
#include <string.h>

#include "base/text.h"
#include "cli/diagnose.h"

/* MOST_CAUSES: causes with a separate line, on a screen of some 30 lines. */
enum { MOST_CAUSES = 8, TEXT = 2 * MUKCA_WORDING };

/* Ratio of held-out errors to their expectation above which a sentence is printed (2 %: the
 * standard deviation of the rms of some thousand coordinates). */
static const double worth_reporting = 1.02;

/* ---- causes ---- */

static void put_amplitude(mukca_text *text, const mukca_cause *c, const mukca_chain *chain)
{
    char amplitude[MUKCA_WORDING], probability[MUKCA_WORDING];
    mukca_wording_amplitude(amplitude, c, chain);
    mukca_wording_probability(probability, c->probability);
    mukca_text_put(text, "%s, %s", amplitude, probability);
}

/* " (indistinguishable in these data; 10 more postures would decide: ...)" */
static void put_tie(mukca_text *text, const mukca_diagnosed *r, const mukca_cause *c)
{
    const mukca_next_poses *next = r->next;
    if (!c->n_ties && !c->or_unknown) return;
    mukca_text_put(text, " (indistinguishable in these data");
    if (mukca_next_poses_need_readings(c)) mukca_text_put(text, "; readings would decide");
    if (next && next->cause >= 0 && c == &r->diagnosis->causes[next->cause]) {
        const mukca_plan *plan = &next->plan;
        const int rows =
            plan->evidence_after >= MUKCA_PLAN_NAME ? plan->n_rows : plan->rows_to_name;
        if (rows > 0)
            mukca_text_put(text, "; %d more postures would %s: mukca plan --settle --rows %d", rows,
                           c->n_ties + c->or_unknown > 1 ? "separate two of these" : "decide",
                           rows);
        else if (r->data->n_sockets > 0)
            mukca_text_put(text,
                           "; a placement far from these may decide: mukca plan --settle --place");
    }
    mukca_text_put(text, ")");
}

/* The first cause has its mechanism or tie on a line of its own. */
static void print_cause(FILE *stream, const mukca_diagnosed *r, const mukca_cause *c,
                        const char *key, bool first)
{
    char line[TEXT] = "", words[MUKCA_WORDING];
    mukca_text text = MUKCA_TEXT(line);
    mukca_wording_rivals(words, c, r);
    mukca_text_put(&text, "%s", words);
    if (first && !c->n_ties && !c->or_unknown)
        mukca_text_put(&text, ": %s", mukca_wording_mechanism(c, r));
    if (first)
        put_tie(&text, r, c);
    else
        mukca_text_put(&text, c->n_ties ? "; " : ", ");
    if (first) cli_print_text(stream, key, &text);
    put_amplitude(&text, c, r->chain);
    if (!first) put_tie(&text, r, c);
    cli_print_text(stream, first ? "" : key, &text);
}

static void print_rest(FILE *stream, const mukca_diagnosis *d)
{
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    const bool unknown = d->verdict == MUKCA_VERDICT_UNKNOWN;
    const bool unexplained = d->unexplained && !unknown;
    if (!unknown)
        mukca_text_put(&text, unexplained ? "unexplained structure" : "nothing above the noise");
    if ((unexplained || unknown) && d->surprise > worth_reporting && isfinite(d->surprise))
        mukca_text_put(&text,
                       "%sheld-out errors are %.2f times those expected from noise and the "
                       "uncertainty of the geometry",
                       unexplained ? ": " : "", d->surprise);
    cli_print_text(stream, "Rest", &text);
}

static void print_causes(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char words[MUKCA_WORDING];
    int printed = d->verdict == MUKCA_VERDICT_UNKNOWN;
    if (printed) {
        mukca_wording_unexplained(words, r);
        cli_print_keyed(stream, "Cause", words);
    }
    for (int i = 0; i < d->n_causes; i++) {
        if (!mukca_wording_on_arm(&d->causes[i])) continue;
        const char *const key = printed == 0 ? "Cause" : printed == 1 ? "Also" : "";
        if (printed <= MOST_CAUSES) print_cause(stream, r, &d->causes[i], key, printed == 0);
        printed++;
    }
    if (printed > MOST_CAUSES + 1) cli_print_more(stream, printed - MOST_CAUSES - 1);
    if (printed) {
        print_rest(stream, d);
        return;
    }
    mukca_wording_verdict(words, r);
    cli_print_keyed(stream, "Cause", words);
}

/* ---- held-out errors ---- */

/* "; the causes reduce it by 36 % [30, 41], in 3 of 3 folds" */
static void put_gain(mukca_text *text, const mukca_shrink *s)
{
    if (!isfinite(s->shrink_percent)) return;
    const bool more = s->shrink_percent < 0;
    mukca_text_put(text, "; the causes %s it by %.0f %%", more ? "raise" : "reduce",
                   fabs(s->shrink_percent));
    if (isfinite(s->low_percent) && isfinite(s->high_percent))
        mukca_text_put(text, " [%.0f, %.0f]%s", /* + 0: no -0 */
                       rint(more ? -s->high_percent : s->low_percent) + 0,
                       rint(more ? -s->low_percent : s->high_percent) + 0,
                       s->low_percent > 0 ? "" : ", not significant");
    mukca_text_put(text, ", in %d of %d folds", s->folds_better, s->folds);
}

static void print_errors(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char line[TEXT] = "";
    mukca_text text = MUKCA_TEXT(line);
    mukca_step steps[MUKCA_MAX_STEPS];
    const int n = mukca_wording_steps(steps, r);
    if (!isfinite(d->nominal_m)) return;
    fprintf(stream, "\n%sMean error, mm%s%26s%s\n", cli_bold(stream), cli_plain(stream),
            d->folds > 1 ? "cross-validated" : "training",
            isfinite(d->test_geometry_m) ? "    test" : "");
    for (int i = 0; i < n; i++) {
        if (!isfinite(steps[i].cross_validated_m)) continue;
        fprintf(stream, "  %-28s %12.3f", steps[i].name, 1e3 * steps[i].cross_validated_m);
        if (isfinite(steps[i].test_m)) fprintf(stream, " %8.3f", 1e3 * steps[i].test_m);
        fputc('\n', stream);
    }
    if (d->folds > 1) {
        mukca_text_put(&text, "Cross-validated: each %s predicted from the others",
                       r->data->n_placements >= 2 ? "placement"
                       : r->data->n_sockets > 0   ? "socket"
                                                  : "fold of the log");
        if (d->n_causes) put_gain(&text, &d->held_out);
        cli_print_text(stream, NULL, &text);
    }
    if (mukca_wording_worse(d))
        fputs("The causes increase the error on the test data: they are uncertain.\n", stream);
    if (r->data->n_sockets == 0 || r->data->n_placements >= 4 || !d->n_causes) return;
    mukca_text_put(&text, "Fewer than four placements: the reduction by the causes is uncertain");
    if (isfinite(d->noise_shrink_percent))
        mukca_text_put(
            &text, " (on pure noise the best effect of the catalogue reduces the error by %.0f %%)",
            d->noise_shrink_percent);
    cli_print_text(stream, NULL, &text);
}

void cli_diagnosis_print(FILE *stream, const mukca_diagnosed *r)
{
    char words[MUKCA_WORDING], test[80];
    cli_describe_data(words, r->data);
    if (r->test) cli_describe_data(test, r->test);
    fprintf(stream, "%s: %s%s%s\n", r->chain->robot, words, r->test ? "; test: " : "",
            r->test ? test : "");
    if (r->acceptance) cli_print_acceptance(stream, r->acceptance, r->chain);
    mukca_wording_caveat(words, r);
    const bool caveat = *words;
    cli_print_wrapped(stream, words);
    if (r->diagnosis->verdict == MUKCA_VERDICT_UNTESTABLE) {
        mukca_wording_verdict(words, r);
        cli_print_wrapped(stream, words);
        cli_screen_recording(stream, r);
        return;
    }
    fputc('\n', stream);
    print_causes(stream, r);
    cli_screen_logs(stream, r);
    cli_screen_streams(stream, r);
    cli_screen_recording(stream, r);
    print_errors(stream, r);
    if (r->check) {
        mukca_wording_check(words, r);
        fputc('\n', stream);
        cli_print_keyed(stream, "Check", words);
    }
    cli_screen_limits(stream, r, caveat);
    mukca_wording_next(words, r);
    if (*words) cli_print_keyed(stream, "Next", words);
}

void cli_diagnosis_print_sets(FILE *stream, const mukca_diagnosed *r)
{
    const mukca_diagnosis *d = r->diagnosis;
    char row[MUKCA_WORDING], other[MUKCA_WORDING];
    bool printed[MUKCA_MAX_SETS] = {false};
    double rest = 1;
    if (d->n_sets == 0) return;
    fprintf(stream, "\n%sSets of causes%s by posterior probability\n", cli_bold(stream),
            cli_plain(stream));
    for (int i = 0; i < d->n_sets; i++) { /* sets of the same names are one row */
        double probability = 0;
        if (printed[i]) continue;
        mukca_wording_set(row, &d->sets[i], r);
        for (int k = i; k < d->n_sets; k++) {
            mukca_wording_set(other, &d->sets[k], r);
            if (printed[k] || strcmp(row, other) != 0) continue;
            printed[k] = true;
            probability += d->sets[k].probability;
        }
        fprintf(stream, "  %5.1f %%  ", 100 * probability);
        cli_print_words(stream, 11, 11, row, strlen(row));
        rest -= probability;
    }
    if (rest > 5e-4) fprintf(stream, "  %5.1f %%  other sets\n", 100 * rest);
}
