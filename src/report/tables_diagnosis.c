/* Texts and tables of the diagnosis: verdict, what to do, causes, faults, detection limits. */
#include <math.h>
#include <string.h>

#include "report/page.h"
#include "report/report.h"

enum { COLUMNS = 64 + 5 * MUKCA_MAX_JOINTS }; /* characters of headings */

/* Form the headings of a table: `first` and a column of numbers for each joint, by its number. */
static void joint_columns(char columns[COLUMNS], const char *first, const mukca_chain *chain)
{
    int used = sprintf(columns, "%s", first);
    for (int j = 0; j < chain->n_joints; j++) used += sprintf(columns + used, "|#%d", j + 1);
}

/* ---- verdict and remedies ---- */

/* Write one item for each remedy, with all causes it applies to. */
static void put_remedies(FILE *out, const mukca_diagnosed *d)
{
    const mukca_cause *causes = d->diagnosis->causes;
    char text[MUKCA_WORDING];
    for (int i = 0; i < d->diagnosis->n_causes; i++) {
        const char *remedy = mukca_wording_remedy(&causes[i], d);
        int first = 0;
        while (mukca_wording_remedy(&causes[first], d) != remedy) first++;
        if (first < i) continue;
        fputs("<li>", out);
        mukca_html_sentence(out, remedy);
        fputs(" <small>(", out);
        for (int k = i; k < d->diagnosis->n_causes; k++) {
            if (mukca_wording_remedy(&causes[k], d) != remedy) continue;
            fputs(k > i ? "; " : "", out);
            mukca_wording_rivals(text, &causes[k], d);
            mukca_html_escape(out, text);
        }
        fputs(")</small></li>\n", out);
    }
}

/* Write the next step that the diagnosis recommends, else how to use its result. */
static void put_next(FILE *out, const mukca_diagnosed *d)
{
    char next[MUKCA_WORDING];
    bool on_arm = false;
    mukca_wording_next(next, d);
    for (int i = 0; i < d->diagnosis->n_causes; i++)
        on_arm |= mukca_wording_on_arm(&d->diagnosis->causes[i]);
    if (!*next)
        snprintf(next, sizeof next,
                 "`mukca diagnose` with these data and `-o offsets.tsv` saves the geometry%s for "
                 "fk, evaluate, compensate and export",
                 on_arm ? " and the causes" : "");
    fputs("<li>", out);
    mukca_html_sentence(out, next);
    fputs(".</li>\n", out);
}

void mukca_report_put_verdict(FILE *out, const mukca_report *r)
{
    const mukca_diagnosed *d = &r->diagnosed;
    char text[MUKCA_WORDING];
    fprintf(out, "<p class=\"verdict %s\">", mukca_verdict_name[d->diagnosis->verdict]);
    mukca_wording_verdict(text, d);
    mukca_html_sentence(out, text);
    fputs(".</p>\n", out);
    mukca_wording_caveat(text, d);
    if (*text) mukca_html_element(out, "p", text);
    if (d->check) {
        mukca_wording_check(text, d);
        fputs("<p>Check: ", out);
        mukca_html_sentence(out, text);
        fputs(".</p>\n", out);
    }
    fputs("<h2 id=\"to-do\">What to do</h2>\n<ul>\n", out);
    put_remedies(out, d);
    put_next(out, d);
    fputs("</ul>\n", out);
}

/* ---- causes ---- */

void mukca_report_put_causes(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const mukca_diagnosed *d = &r->diagnosed;
    char words[MUKCA_WORDING], amplitude[MUKCA_WORDING], probability[MUKCA_WORDING];
    mukca_html_table table = {
        .out = out,
        .caption =
            "Causes, the largest contribution first; after \"or\": indistinguishable in these data",
        .style = "cards",
        .columns = "cause|size [95 % interval]|probability|mechanism"};
    mukca_report_put_steps(out, r);
    for (int i = 0; i < d->diagnosis->n_causes; i++) {
        const mukca_cause *cause = &d->diagnosis->causes[i];
        mukca_wording_rivals(words, cause, d);
        mukca_wording_amplitude(amplitude, cause, d->chain);
        mukca_wording_probability(probability, cause->probability);
        mukca_html_row(&table, "%s\t%s\t%s\t%s", words, amplitude,
                       probability + strlen("probability "), mukca_wording_mechanism(cause, d));
    }
    mukca_html_table_end(&table);
}

/* ---- recording faults ---- */

void mukca_report_put_faults(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    char words[MUKCA_WORDING];
    fputs(d->n_faults ? "<ul>\n" : "<p>No recording fault was found.</p>\n", out);
    for (int i = 0; i < d->n_faults; i++) {
        mukca_wording_fault(words, &d->faults[i], &r->diagnosed);
        mukca_html_element(out, "li", words);
    }
    if (d->n_faults) fputs("</ul>\n", out);
}

/* ---- detection limits ---- */

static void put_untestable(FILE *out, const mukca_report *r)
{
    char words[MUKCA_WORDING];
    int listed = 0;
    for (int i = 0; i < r->diagnosed.diagnosis->n_tested; i++) {
        if (!mukca_wording_untestable(words, i, &r->diagnosed, false)) continue;
        fputs(listed++ ? "" : "<p>Not testable with these data:</p>\n<ul>\n", out);
        mukca_html_element(out, "li", words);
    }
    if (listed) fputs("</ul>\n", out);
}

/* Smallest detection limit of an effect at a joint (-1: no joint), rad or m; NaN: not testable. */
static double limit_of(const mukca_diagnosis *d, int effect, int joint)
{
    double limit = NAN;
    for (int i = 0; i < d->n_tested; i++)
        if ((int)d->tested[i].effect == effect && d->tested[i].joint == joint &&
            d->tested[i].testable)
            limit = fmin(limit, d->tested[i].limit);
    return limit;
}

void mukca_report_put_limits(FILE *out, const void *content)
{
    const mukca_report *r = content;
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    char columns[COLUMNS], name[MUKCA_WORDING];
    joint_columns(columns, "effect|#arm, tool", r->chain);
    mukca_html_table table = {.out = out,
                              .caption =
                                  "Smallest effects that these data would show, by joint from base "
                                  "to tip, mrad rms at the joint or mm rms",
                              .columns = columns};
    if (d->n_tested == 0) fputs("<p>No effect was tested.</p>\n", out);
    for (int effect = 0; effect < MUKCA_EFFECT_COUNT; effect++) {
        bool any = false;
        for (int j = -1; j < r->chain->n_joints; j++) any |= isfinite(limit_of(d, effect, j));
        if (!any) continue;
        mukca_wording_effect(name, (mukca_effect_kind)effect, NULL);
        mukca_html_row(&table, "%s", name);
        for (int j = -1; j < r->chain->n_joints; j++)
            mukca_html_cells(&table, "%.2f", limit_of(d, effect, j) * MUKCA_REPORT_MM);
    }
    mukca_html_table_end(&table);
    put_untestable(out, r);
}
