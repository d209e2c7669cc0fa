/* Texts and tables of the diagnosis: verdict, what to do, causes, faults, detection limits. */
#include <math.h>

#include "report/report.h"

/* ---- verdict and remedies ---- */

/* Write one item for each remedy, with all causes it applies to. */
static void put_remedies(FILE *out, const mukca_diagnosed *d)
{
    const mukca_cause *first = d->diagnosis->causes, *end = first + d->diagnosis->n_causes;
    for (const mukca_cause *c = first; c < end; c++) {
        const char *remedy = mukca_wording_remedy(c, d);
        const mukca_cause *same = first;
        while (mukca_wording_remedy(same, d) != remedy) same++;
        if (same < c) continue;
        mukca_html_sentence(out, "<li>", remedy, " <small>(");
        for (; same < end; same++) {
            if (mukca_wording_remedy(same, d) != remedy) continue;
            fputs(same > c ? "; " : "", out);
            mukca_html_escape(
                out, mukca_wording_effect(MUKCA_WORDS, same->effect.kind,
                                          mukca_chain_joint_name(d->chain, same->effect.joint)));
        }
        fputs(")</small></li>\n", out);
    }
}

void mukca_report_put_verdict(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const mukca_diagnosed *d = &r->diagnosed;
    char next[MUKCA_WORDING] = "";
    bool on_arm = false;
    for (int i = 0; i < d->diagnosis->n_causes; i++)
        on_arm |= mukca_wording_on_arm(&d->diagnosis->causes[i]);
    if (!*mukca_wording_next(next, d)) /* then how to use the result */
        mukca_wording_put(next,
                          "`mukca diagnose` with these data and `-o offsets.tsv` saves the "
                          "geometry%s for fk, evaluate, compensate and export",
                          on_arm ? " and the causes" : "");
    fprintf(out, "<p class=\"verdict %s\">", mukca_verdict_name[d->diagnosis->verdict]);
    mukca_html_sentence(out, "", mukca_wording_verdict(MUKCA_WORDS, d), ".</p>\n");
    mukca_html_sentence(out, "<p>", mukca_wording_caveat(MUKCA_WORDS, d), "</p>");
    fputs("<h2 id=\"to-do\">What to do</h2>\n<ul>\n", out);
    put_remedies(out, d);
    mukca_html_sentence(out, "<li>", next, ".</li>\n</ul>\n");
}

/* ---- causes ---- */

static void put_steps(FILE *out, const mukca_diagnosed *diagnosed)
{
    const mukca_diagnosis *d = diagnosed->diagnosis;
    mukca_step steps[MUKCA_MAX_STEPS];
    const int n = mukca_wording_steps(steps, diagnosed);
    const bool tested = isfinite(steps[0].test_m);
    double most = 0;
    mukca_html_table table = {
        .out = out,
        .caption = d->folds > 1 ? "Mean error, mm, each line a fit of its own; cross-validated: "
                                  "each fold predicted from the others"
                                : "Mean error, mm, each line a fit of its own",
        .columns = mukca_wording_put(MUKCA_WORDS, "model|#%s|bar|%s",
                                     d->folds > 1 ? "cross-validated" : "training",
                                     tested ? "#test" : "")};
    for (int i = 1; i < n; i++) most = fmax(most, steps[i].cross_validated_m);
    for (int i = 0; i < n; i++) {
        const double error = steps[i].cross_validated_m;
        const double bar = i ? 100 * error / most : 0; /* the nominal error is off the scale */
        if (isfinite(error))
            mukca_html_row(&table, tested ? "%s\t%.3f\t%.0f\t%.3f" : "%s\t%.3f\t%.0f",
                           steps[i].name, 1e3 * error, bar, 1e3 * steps[i].test_m);
    }
    mukca_html_table_end(&table);
}

void mukca_report_put_causes(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const mukca_diagnosed *d = &r->diagnosed;
    mukca_html_table table = {
        .out = out,
        .caption = "Findings, the largest first: displacement of the tip, rms in these samples",
        .style = "cards",
        .columns = "finding|size [95 % interval], mm|certainty|alternatives"};
    const mukca_diagnosis *diagnosis = d->diagnosis;
    put_steps(out, d);
    for (int i = 0; i < diagnosis->n_findings + diagnosis->n_maybe; i++) {
        const bool sure = i < diagnosis->n_findings;
        const mukca_finding *f =
            sure ? &diagnosis->findings[i] : &diagnosis->maybe[i - diagnosis->n_findings];
        const char *certainty =
            sure ? mukca_wording_certainty(MUKCA_WORDS, f, d)
                 : mukca_wording_put(MUKCA_WORDS, "maybe, %.0f %%", 100 * f->group.probability);
        mukca_html_row(&table, "%s\t%.3f [%.3f, %.3f]\t%s\t%s",
                       mukca_wording_finding(MUKCA_WORDS, f, d), 1e3 * f->size_m.value,
                       1e3 * f->size_m.low, 1e3 * f->size_m.high, certainty,
                       mukca_wording_alternatives(MUKCA_WORDS, f, d));
    }
    mukca_html_table_end(&table);
}

/* ---- the recording ---- */

void mukca_report_put_faults(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    mukca_wording_text *const texts[] = {mukca_wording_logs, mukca_wording_angles,
                                         mukca_wording_efforts};
    fputs(d->n_faults ? "<ul>\n" : "<p>No recording fault was found.</p>\n", out);
    for (int i = 0; i < d->n_faults; i++)
        mukca_html_element(out, "li",
                           mukca_wording_fault(MUKCA_WORDS, &d->faults[i], &r->diagnosed));
    if (d->n_faults) fputs("</ul>\n", out);
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        mukca_html_sentence(out, "<p>", texts[i](MUKCA_WORDS, &r->diagnosed), ".</p>\n");
}

/* ---- detection limits ---- */

void mukca_report_put_limits(FILE *out, const void *content)
{
    const mukca_diagnosed *d = &((const mukca_report *)content)->diagnosed;
    int listed = 0;
    mukca_html_sentence(out, "<p>", mukca_wording_limits(MUKCA_WORDS, d), ".</p>\n");
    for (int i = 0; i < d->diagnosis->n_tested; i++) {
        const char *words = mukca_wording_untestable(MUKCA_WORDS, i, d);
        if (!*words) continue;
        fputs(listed++ ? "" : "<p>Not testable with these data:</p>\n<ul>\n", out);
        mukca_html_element(out, "li", words);
    }
    if (listed) fputs("</ul>\n", out);
}
