/* Texts and tables of the diagnosis: verdict, what to do, causes, faults, detection limits. */
#include <math.h>
#include <string.h>

#include "base/text.h"
#include "report/html.h"
#include "report/parts.h"

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

static void put_next_poses(FILE *out, const mukca_report *r)
{
    const mukca_next_poses *next = r->diagnosed.next;
    const mukca_chain *chain = r->chain;
    char columns[COLUMNS], text[MUKCA_WORDING];
    if (next->cause < 0 || next->plan.n_rows == 0) return;
    const mukca_cause *cause = &r->diagnosed.diagnosis->causes[next->cause];
    const mukca_effect *rival = &cause->ties[next->tie].rival;
    fputs("<h2 id=\"next\">Next postures</h2>\n<p>They separate ", out);
    mukca_wording_cause(text, cause, &r->diagnosed);
    mukca_html_escape(out, text);
    fputs(" from ", out);
    mukca_wording_effect(text, rival->kind, mukca_chain_joint_name(chain, rival->joint));
    mukca_html_escape(out, text);
    fputs(".</p>\n", out);
    joint_columns(columns, "placement|socket", chain);
    mukca_html_table table = {
        .out = out, .caption = "Next postures: joints from base to tip, rad", .columns = columns};
    for (int i = 0; i < next->plan.n_rows; i++) {
        const mukca_plan_row *row = &next->plan.rows[i];
        const mukca_plan_socket *socket = &next->sockets[row->socket];
        mukca_html_row(&table, "%s\t%s", socket->placement, socket->label);
        for (int j = 0; j < chain->n_joints; j++) mukca_html_cells(&table, "%.2f", row->q[j]);
    }
    mukca_html_table_end(&table);
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
    put_next_poses(out, r);
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
    const mukca_dataset *data = r->train;
    mukca_html_table table = {.out = out,
                              .caption = "Recording faults",
                              .columns = "fault|placement|socket|#row of the file|#size, mm"};
    if (d->n_faults == 0) fputs("<p>No recording fault was found.</p>\n", out);
    for (int i = 0; i < d->n_faults; i++) {
        const mukca_data_fault *fault = &d->faults[i];
        char kind[64];
        snprintf(kind, sizeof kind, "%s", mukca_fault_name[fault->kind]);
        for (char *c = kind; *c; c++)
            if (*c == '_') *c = ' ';
        mukca_html_row(&table, "%s\t%s\t%s\t%d\t%.2f", kind,
                       fault->placement < 0 ? "" : data->placements[fault->placement].name,
                       fault->socket < 0 ? "" : data->sockets[fault->socket].label, fault->row,
                       fault->size_m * MUKCA_REPORT_MM);
    }
    mukca_html_table_end(&table);
}

/* ---- detection limits ---- */

/* Whether two tested effects are not testable for the same reason. */
static bool same_reason(const mukca_tested *a, const mukca_tested *b)
{
    return !a->testable && !b->testable && a->effect == b->effect && strcmp(a->why, b->why) == 0;
}

static void put_untestable(FILE *out, const mukca_report *r)
{
    const mukca_tested *tested = r->diagnosed.diagnosis->tested;
    const int n = r->diagnosed.diagnosis->n_tested;
    mukca_html_table table = {.out = out,
                              .caption = "Not testable with these data",
                              .style = "cards",
                              .columns = "effect|joints|reason"};
    for (int i = 0; i < n; i++) {
        char name[MUKCA_WORDING], names[MUKCA_MAX_JOINTS * (MUKCA_NAME_SIZE + 2)] = "";
        mukca_text joints = MUKCA_TEXT(names);
        int first = 0;
        while (first < i && !same_reason(&tested[first], &tested[i])) first++;
        if (tested[i].testable || first < i ||
            (r->data.n_sockets == 0 && mukca_effect_of_sockets(tested[i].effect)))
            continue;
        for (int k = i; k < n; k++) {
            if (tested[k].joint < 0 || !same_reason(&tested[k], &tested[i])) continue;
            mukca_text_put(&joints, "%s%s", joints.used ? ", " : "",
                           mukca_chain_joint_name(r->chain, tested[k].joint));
        }
        mukca_wording_effect(name, tested[i].effect, NULL);
        mukca_html_row(&table, "%s\t%s\t%s", name, names, tested[i].why);
    }
    mukca_html_table_end(&table);
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
                                  "to tip, mrad rms at the "
                                  "joint or mm rms",
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
