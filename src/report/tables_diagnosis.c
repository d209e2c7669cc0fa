/* Texts and tables of the diagnosis: verdict, what to do, causes, faults, detection limits. */
#include <ctype.h>
#include <math.h>
#include <string.h>

#include "report/html.h"
#include "report/tables.h"

static const double mm = 1e3;

/* First letter large, text in backticks as code, `stop` at the end. */
static void put_sentence(FILE *out, const char *text, const char *stop)
{
    const char first[2] = {(char)toupper((unsigned char)*text), '\0'};
    bool code = false;
    if (!*text) return;
    if (*text != '`') mukca_html_escape(out, first);
    for (text += *text != '`'; *text;) {
        char piece[MUKCA_WORDING];
        const size_t n = strcspn(text, "`");
        snprintf(piece, sizeof piece, "%.*s", (int)n, text);
        mukca_html_escape(out, piece);
        text += n;
        if (*text != '`') break;
        code = !code, text++;
        fputs(code ? "<code>" : "</code>", out);
    }
    fputs(stop, out);
}

/* ---- verdict and what to do ---- */

/* Is this remedy, and with `text` this wording of the cause, that of an earlier cause? */
static bool repeated(const mukca_diagnosed *d, int index, const char *text)
{
    char other[MUKCA_WORDING];
    for (int k = 0; k < index; k++) {
        const mukca_cause *cause = &d->diagnosis->causes[k];
        if (mukca_wording_remedy(cause) != mukca_wording_remedy(&d->diagnosis->causes[index]))
            continue;
        mukca_wording_rivals(other, cause, d);
        if (!text || strcmp(text, other) == 0) return true;
    }
    return false;
}

/* One item for each remedy, with all causes that it is for. */
static void put_remedies(FILE *out, const mukca_diagnosed *d)
{
    char text[MUKCA_WORDING];
    for (int i = 0; i < d->diagnosis->n_causes; i++) {
        const char *remedy = mukca_wording_remedy(&d->diagnosis->causes[i]);
        if (repeated(d, i, NULL)) continue;
        fputs("<li>", out);
        put_sentence(out, remedy, " <small>(");
        for (int k = i; k < d->diagnosis->n_causes; k++) {
            mukca_wording_rivals(text, &d->diagnosis->causes[k], d);
            if (remedy != mukca_wording_remedy(&d->diagnosis->causes[k]) || repeated(d, k, text))
                continue;
            fputs(k > i ? "; " : "", out);
            mukca_html_escape(out, text);
        }
        fputs(")</small></li>\n", out);
    }
}

/* What the diagnosis asks for, else how to use its result. */
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
    put_sentence(out, next, ".</li>\n");
}

void mukca_report_put_verdict(FILE *out, const mukca_report *r)
{
    const mukca_diagnosed *d = &r->diagnosed;
    char verdict[MUKCA_WORDING], caveat[MUKCA_WORDING];
    if (r->fit && !r->fit->converged)
        fputs(
            "<p class=\"verdict unknown\">The calibration did not converge: do not use its "
            "numbers.</p>\n",
            out);
    mukca_wording_verdict(verdict, d);
    mukca_wording_caveat(caveat, d);
    fprintf(out, "<p class=\"verdict %s\">", mukca_verdict_name[d->diagnosis->verdict]);
    put_sentence(out, verdict, ".</p>\n");
    if (*caveat) {
        fputs("<p>", out);
        mukca_html_escape(out, caveat);
        fputs("</p>\n", out);
    }
    fputs("<h2 id=\"to-do\">What to do</h2>\n<ul>\n", out);
    put_remedies(out, d);
    put_next(out, d);
    fputs("</ul>\n", out);
    mukca_report_put_next_poses(out, r);
}

void mukca_report_put_next_poses(FILE *out, const mukca_report *r)
{
    const mukca_next_poses *next = r->diagnosed.next;
    const mukca_chain *chain = r->chain;
    char columns[MUKCA_MAX_JOINTS * (MUKCA_NAME_SIZE + 2) + 64] = "placement|socket";
    if (!next || next->cause < 0 || next->plan.n_rows == 0) return;
    char text[MUKCA_WORDING];
    const mukca_cause *cause = &r->diagnosed.diagnosis->causes[next->cause];
    fputs("<h2 id=\"next\">Next postures</h2>\n<p>They separate ", out);
    mukca_wording_cause(text, cause, &r->diagnosed);
    mukca_html_escape(out, text);
    fputs(" from ", out);
    const mukca_effect *rival = &cause->ties[next->tie].rival;
    mukca_wording_effect(text, rival->kind, chain, rival->joint);
    mukca_html_escape(out, text);
    fputs(".</p>\n", out);
    for (int j = 0; j < chain->n_joints; j++) {
        strcat(columns, "|#");
        strcat(columns, mukca_wording_joint(chain, j));
    }
    mukca_html_table table = {.out = out, .columns = columns};
    mukca_html_table_begin(&table, "Next postures, rad");
    for (int i = 0; i < next->plan.n_rows; i++) {
        const mukca_plan_row *row = &next->plan.rows[i];
        mukca_html_table_row(&table);
        mukca_html_table_text(&table, next->sockets[row->socket].placement);
        mukca_html_table_text(&table, next->sockets[row->socket].label);
        for (int j = 0; j < chain->n_joints; j++) mukca_html_table_number(&table, row->q[j], 3);
    }
    mukca_html_table_end(&table);
}

/* ---- causes ---- */

static void put_ties(FILE *out, const mukca_diagnosed *d)
{
    mukca_html_table table = {
        .out = out,
        .cards = true,
        .columns = "cause|alternative|#log Bayes factor|#of the alternative|#correlation"};
    bool any = false;
    for (int i = 0; i < d->diagnosis->n_causes; i++) {
        const mukca_cause *cause = &d->diagnosis->causes[i];
        for (int k = 0; k < cause->n_ties; k++) {
            const mukca_tie *tie = &cause->ties[k];
            char text[MUKCA_WORDING];
            if (!any) mukca_html_table_begin(&table, "Indistinguishable in these data");
            any = true;
            mukca_html_table_row(&table);
            mukca_wording_cause(text, cause, d);
            mukca_html_table_text(&table, text);
            mukca_wording_effect(text, tie->effect, d->chain, tie->joint);
            mukca_html_table_text(&table, text);
            mukca_html_table_number(&table, cause->log_bayes_factor, 1);
            mukca_html_table_number(&table, tie->log_bayes_factor, 1);
            mukca_html_table_number(&table, tie->correlation, 2);
        }
    }
    if (any) mukca_html_table_end(&table);
}

/* Shade of a cell by its correlation; the number stays readable on it. */
static void put_shade(FILE *out, double correlation)
{
    if (isfinite(correlation))
        fprintf(out, "<td class=\"n\" style=\"--share:%.0f%%\">%.2f</td>", 45 * correlation,
                correlation);
    else
        fputs("<td class=\"n\">&ndash;</td>", out);
}

/* Matrix of what is confounded with what. */
static void put_confounding(FILE *out, const mukca_diagnosed *d)
{
    const mukca_confounding *c = &d->diagnosis->confounding;
    char text[MUKCA_WORDING];
    if (c->n < 2) return;
    fputs(
        "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Confounding\">\n"
        "<table class=\"matrix\">\n<caption>Confounding <small>Canonical correlation of each pair "
        "after geometry is projected out; 1: indistinguishable. Causes in bold, the others are "
        "close candidates.</small></caption>\n<thead><tr><td></td>",
        out);
    for (int i = 0; i < c->n; i++) fprintf(out, "<th scope=\"col\" class=\"n\">%d</th>", i + 1);
    fputs("</tr></thead>\n<tbody>\n", out);
    for (int i = 0; i < c->n; i++) {
        const mukca_cause item = {.effect = c->effects[i], .socket = -1};
        mukca_wording_cause(text, &item, d);
        fprintf(out, "<tr><th scope=\"row\"%s>%d ", c->cause[i] ? "" : " class=\"light\"", i + 1);
        mukca_html_escape(out, text);
        fputs("</th>", out);
        for (int k = 0; k < c->n; k++) put_shade(out, c->correlation[i][k]);
        fputs("</tr>\n", out);
    }
    fputs("</tbody>\n</table>\n</div>\n", out);
}

void mukca_report_put_causes(FILE *out, const mukca_report *r)
{
    const mukca_diagnosed *d = &r->diagnosed;
    if (d->diagnosis->n_causes == 0) return;
    mukca_html_table table = {
        .out = out, .cards = true, .columns = "cause|size [95 % interval]|probability|mechanism"};
    mukca_html_table_begin(&table, "Causes, the largest contribution first");
    for (int i = 0; i < d->diagnosis->n_causes; i++) {
        const mukca_cause *cause = &d->diagnosis->causes[i];
        char text[MUKCA_WORDING];
        mukca_html_table_row(&table);
        mukca_wording_cause(text, cause, d);
        const size_t used = strlen(text);
        if (cause->row > 0) snprintf(text + used, sizeof text - used, ", row %d", cause->row);
        mukca_html_table_text(&table, text);
        mukca_wording_amplitude(text, cause, d->chain);
        mukca_html_table_text(&table, text);
        mukca_wording_probability(text, cause->probability);
        mukca_html_table_text(&table, text + strlen("probability "));
        mukca_html_table_text(&table, mukca_effect_table[cause->effect.kind]->sentence);
    }
    mukca_html_table_end(&table);
    put_ties(out, d);
    put_confounding(out, d);
}

/* ---- recording faults ---- */

void mukca_report_put_faults(FILE *out, const mukca_report *r)
{
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    const mukca_dataset *data = r->train;
    if (d->n_faults == 0) {
        fputs("<p>No recording fault was found.</p>\n", out);
        return;
    }
    mukca_html_table table = {.out = out,
                              .columns = "fault|placement|socket|#row of the file|#size, mm"};
    mukca_html_table_begin(&table, "Recording faults");
    for (int i = 0; i < d->n_faults; i++) {
        const mukca_data_fault *fault = &d->faults[i];
        char kind[64];
        snprintf(kind, sizeof kind, "%s", mukca_fault_name[fault->kind]);
        for (char *c = kind; *c; c++)
            if (*c == '_') *c = ' ';
        mukca_html_table_row(&table);
        mukca_html_table_text(&table, kind);
        mukca_html_table_text(&table,
                              fault->placement < 0 ? "" : data->placements[fault->placement].name);
        mukca_html_table_text(&table, fault->socket < 0 ? "" : data->sockets[fault->socket].label);
        mukca_html_table_number(&table, fault->row, 0);
        mukca_html_table_number(&table, fault->size_m * mm, 2);
    }
    mukca_html_table_end(&table);
}

/* ---- detection limits ---- */

/* Same effect, same reason? */
static bool same_reason(const mukca_tested *a, const mukca_tested *b)
{
    return a->effect == b->effect && strcmp(a->why, b->why) == 0;
}

static void put_untestable(FILE *out, const mukca_report *r)
{
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    mukca_html_table table = {.out = out, .cards = true, .columns = "effect|joints|reason"};
    bool any = false;
    for (int i = 0; i < d->n_tested; i++) {
        const mukca_tested *t = &d->tested[i];
        char name[MUKCA_WORDING], joints[MUKCA_MAX_JOINTS * MUKCA_NAME_SIZE] = "";
        bool listed = t->testable || !t->why;
        for (int k = 0; k < i && !listed; k++)
            listed = !d->tested[k].testable && d->tested[k].why && same_reason(t, &d->tested[k]);
        if (listed) continue;
        for (int k = i; k < d->n_tested; k++) {
            const mukca_tested *other = &d->tested[k];
            const size_t used = strlen(joints);
            if (!other->testable && other->why && other->joint >= 0 && same_reason(t, other))
                snprintf(joints + used, sizeof joints - used, "%s%s", used ? ", " : "",
                         mukca_wording_joint(r->chain, other->joint));
        }
        if (!any) mukca_html_table_begin(&table, "Not testable with these data");
        any = true;
        mukca_html_table_row(&table);
        mukca_wording_effect(name, t->effect, r->chain, -1);
        mukca_html_table_text(&table, name);
        mukca_html_table_text(&table, joints);
        mukca_html_table_text(&table, t->why);
    }
    if (any) mukca_html_table_end(&table);
}

/* Smallest detection limit of an effect at a joint (-1: at none), rad or m; NaN: not testable. */
static double limit_of(const mukca_diagnosis *d, int effect, int joint)
{
    double limit = NAN;
    for (int i = 0; i < d->n_tested; i++)
        if ((int)d->tested[i].effect == effect && d->tested[i].joint == joint &&
            d->tested[i].testable)
            limit = fmin(limit, d->tested[i].limit);
    return limit;
}

void mukca_report_put_limits(FILE *out, const mukca_report *r)
{
    const mukca_diagnosis *d = r->diagnosed.diagnosis;
    char columns[MUKCA_MAX_JOINTS * (MUKCA_NAME_SIZE + 2) + 64] = "effect|#arm or tool";
    for (int j = 0; j < r->chain->n_joints; j++) {
        strcat(columns, "|#");
        strcat(columns, mukca_wording_joint(r->chain, j));
    }
    mukca_html_table table = {.out = out, .columns = columns};
    mukca_html_table_begin(
        &table, "Smallest effects that these data would show, mrad rms at the joint or mm rms");
    for (int effect = 0; effect < MUKCA_EFFECT_COUNT; effect++) {
        char name[MUKCA_WORDING];
        bool any = false;
        for (int j = -1; j < r->chain->n_joints; j++) any |= isfinite(limit_of(d, effect, j));
        if (!any) continue;
        mukca_html_table_row(&table);
        mukca_wording_effect(name, (mukca_effect_kind)effect, r->chain, -1);
        mukca_html_table_text(&table, name);
        for (int j = -1; j < r->chain->n_joints; j++)
            mukca_html_table_number(&table, limit_of(d, effect, j) * mm, 2);
    }
    mukca_html_table_end(&table);
    put_untestable(out, r);
}
