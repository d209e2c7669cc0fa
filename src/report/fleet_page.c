/* The report of a fleet: its wording; verdict, departing arms, coefficients arm by arm, ripple. */
#include "report/report.h"

#include <math.h>

#include "base/text.h"
#include "math/stats.h"
#include "report/page.h"

enum {
    MOST_ROWS = 200, /* largest number of rows of a table */
    MOST_ARMS = 24   /* as many names as fit a figure */
};
static const double per = MUKCA_WORDING_PER_SPRING;

/* ---- wording, shared with the screen ---- */

static void put_effect(char text[MUKCA_WORDING], const mukca_effect *e, const mukca_fleet *f)
{
    mukca_wording_effect(text, e->kind, e->joint < 0 ? NULL : f->model.joint[e->joint]);
}

void mukca_wording_fleet_trait(char text[MUKCA_WORDING], const mukca_trait *t, const mukca_fleet *f)
{
    char effect[MUKCA_WORDING], probability[MUKCA_WORDING];
    put_effect(effect, &t->effect, f);
    mukca_wording_probability(probability, t->probability);
    if (t->effect.variant.order)
        snprintf(text, MUKCA_WORDING, "%.200s, %d per turn, seen in %d of %d arms, %.60s", effect,
                 t->effect.variant.order, t->arms, f->n_arms, probability);
    else
        snprintf(text, MUKCA_WORDING,
                 "%.200s, %.3g " MUKCA_WORDING_SPRING
                 " [%.3g, %.3g], arms differ by %.2g (%.0f %%), %.60s",
                 effect, per * t->value, per * t->low, per * t->high, per * t->spread,
                 100 * t->spread / t->value, probability);
}

void mukca_wording_fleet_departure(char text[MUKCA_WORDING], const mukca_departure *d,
                                   const mukca_fleet *f)
{
    char effect[MUKCA_WORDING], probability[MUKCA_WORDING], ratio[64];
    put_effect(effect, &d->effect, f);
    mukca_wording_probability(probability, d->probability);
    if (!isfinite(d->ratio))
        snprintf(ratio, sizeof ratio, "unlike");
    else if (d->ratio >= 1)
        snprintf(ratio, sizeof ratio, "%.1f times softer than", d->ratio);
    else
        snprintf(ratio, sizeof ratio, "stiffer (%.1f of the deflection) than", d->ratio);
    snprintf(text, MUKCA_WORDING,
             "%.64s: %.200s %s %d sisters, %.3g " MUKCA_WORDING_SPRING
             " [%.3g, %.3g] against %.3g, %.60s",
             f->arm[d->arm].name, effect, ratio, f->n_arms - 1, per * d->value, per * d->low,
             per * d->high, per * d->mean, probability);
}

static bool departs(const mukca_departure *d)
{
    return d->probability >= MUKCA_DEPARTS;
}

/* ---- texts ---- */

static void put_departures(FILE *out, const mukca_fleet_page *p, int n)
{
    char words[MUKCA_WORDING];
    for (int i = 0; i < n && i < MOST_ROWS; i++) {
        const mukca_departure *d = &p->fleet->ranked[i];
        const char *remedy = mukca_effect_table[d->effect.kind]->remedy;
        mukca_wording_fleet_departure(words, d, p->fleet);
        fputs("<li>", out);
        mukca_html_escape(out, n > 1 ? words : p->fleet->arm[d->arm].name);
        fputs(": ", out);
        mukca_html_escape(out, remedy ? remedy : "inspect the transmission");
        fputs("</li>\n", out);
    }
}

/* Verdict, shared properties, and what to do. */
static void open_page(FILE *out, const void *content)
{
    const mukca_fleet_page *p = content;
    const mukca_fleet *f = p->fleet;
    const mukca_traits *t = &p->fleet->traits;
    char words[MUKCA_WORDING] = "No arm departs from the fleet";
    int n = 0, shared = 0;
    for (int a = 0; a < f->n_arms; a++) n += departs(&f->arm[a].departure);
    if (n > 1) snprintf(words, sizeof words, "%d of %d arms depart from the fleet", n, f->n_arms);
    if (n == 1) mukca_wording_fleet_departure(words, p->fleet->ranked, f);
    if (f->n_arms < 3) snprintf(words, sizeof words, "Departures are not testable with two arms");
    fprintf(out, "<p class=\"verdict %s\">", n ? "unknown" : f->n_arms < 3 ? "untestable" : "none");
    mukca_html_escape(out, words);
    fprintf(out,
            ".</p>\n<p>%d arms, %d sessions, %d samples.</p>\n"
            "<h2 id=\"shared\">What the arms share</h2>\n<ul>\n",
            f->n_arms, f->n_sessions, t->n_samples);
    for (int i = 0; i < t->n; i++) {
        if (t->list[i].probability < MUKCA_SHARED) continue;
        mukca_wording_fleet_trait(words, &t->list[i], f);
        mukca_html_element(out, "li", words);
        shared++;
    }
    fputs(shared ? "</ul>\n" : "<li>no elastic coefficient and no order of ripple</li></ul>\n",
          out);
    fputs("<h2 id=\"to-do\">What to do</h2>\n<ul>\n", out);
    put_departures(out, p, n);
    fputs("<li>", out);
    mukca_html_sentence(out,
                        "`mukca fleet` with these summaries and `-o MODEL.traits.tsv` saves what "
                        "the arms share as prior for `diagnose --traits` and `calibrate --traits`");
    fputs(".</li>\n</ul>\n", out);
}

static void put_arms(FILE *out, const void *content)
{
    const mukca_fleet_page *p = content;
    const int n = p->fleet->n_arms;
    char words[MUKCA_WORDING];
    mukca_html_table table = {
        .out = out,
        .caption = "Arms by the probability of a departure, " MUKCA_WORDING_SPRING,
        .columns =
            "arm|#sessions|#samples|largest departure|#value|#from|#to|#sisters|#probability"};
    for (int i = 0; i < n && i < MOST_ROWS; i++) {
        const mukca_departure *d = &p->fleet->ranked[i];
        const mukca_fleet_arm *arm = &p->fleet->arm[d->arm];
        snprintf(words, sizeof words, "not testable");
        if (d->k >= 0) put_effect(words, &d->effect, p->fleet);
        mukca_html_row(&table, "%s\t%d\t%d\t%s", arm->name, arm->end - arm->first, arm->samples,
                       words);
        if (d->k >= 0)
            mukca_html_cells(&table, "%.3g\t%.3g\t%.3g\t%.3g\t%.3f", per * fmax(d->value, 0),
                             per * d->low, per * fmax(d->high, 0), per * d->mean, d->probability);
        else
            mukca_html_cells(&table, "nan\tnan\tnan\tnan\tnan");
    }
    mukca_html_table_end(&table);
    if (n > MOST_ROWS) fprintf(out, "<p>The first %d of %d arms.</p>\n", MOST_ROWS, n);
}

static void put_provenance(FILE *out, const void *content)
{
    const mukca_fleet_page *p = content;
    fputs("<p>Made by ", out);
    mukca_html_element(out, "code", p->command);
    fprintf(out, " at %s.</p>\n", p->when);
}

/* ---- figures ---- */

/* Add the arms' coefficients and names; returns the number of arms drawn. */
static int put_points(mukca_plot *plot, const mukca_fleet_page *p, int k)
{
    int drawn = 0;
    for (int i = 0; i < p->fleet->n_arms && i < MOST_ARMS; i++) {
        const mukca_departure *d = &p->fleet->ranked[i];
        const mukca_departure *e = &p->fleet->arm[d->arm].estimate[k];
        mukca_plot_name(plot, i, p->fleet->arm[d->arm].name);
        if (d->k < 0) continue;
        mukca_plot_add(plot, departs(d) && d->k == k ? MUKCA_PLOT_BEFORE : MUKCA_PLOT_AFTER,
                       (double[]){i, per * fmax(e->value, 0)}, per * fmax(e->low, 0),
                       per * fmax(e->high, 0)); /* estimates may be negative */
        drawn++;
    }
    return drawn;
}

/* Coefficients of the arms side by side. */
static bool draw_coefficient(mukca_plot *plot, const void *content, int index)
{
    const mukca_fleet_page *p = content;
    const int n = p->fleet->n_arms;
    if (index == p->fleet->population.n) return false;
    const mukca_trait *c = &p->fleet->traits.list[index];
    const double value = per * c->value, spread = MUKCA_SIGMAS_95 * per * c->spread;
    char words[MUKCA_WORDING], probability[MUKCA_WORDING];
    mukca_text description = MUKCA_TEXT(plot->words);
    if (!put_points(plot, p, index)) return false;
    put_effect(words, &c->effect, p->fleet);
    mukca_wording_probability(probability, c->probability);
    snprintf(plot->id, sizeof plot->id, "coefficient-%d", index + 1);
    snprintf(plot->title, sizeof plot->title, "%.150s", words);
    snprintf(plot->label[1], sizeof *plot->label, MUKCA_WORDING_SPRING);
    plot->height = 280;
    plot->from_zero = true;
    plot->band[0] = fmax(value - spread, 0);
    plot->band[1] = value;
    plot->band[2] = value + spread;
    mukca_text_put(&description,
                   "Each arm with its 95 %% interval, its sisters as prior; dashed: mean of the "
                   "fleet, %.3g [%.3g, %.3g] if shared (%s); grey: range of 95 %% of its arms.",
                   value, per * c->low, per * c->high, probability);
    if (n > MOST_ARMS)
        mukca_text_put(&description, " The %d of %d arms that are most probable to depart.",
                       MOST_ARMS, n);
    return true;
}

static const mukca_page_section sections[] = {
    {"arms", "Arms", NULL, put_arms},
    {"coefficients", "Elastic coefficients, arm by arm", draw_coefficient, NULL},
    {"provenance", "Provenance", NULL, put_provenance},
};

mukca_page mukca_fleet_page_of(const mukca_fleet_page *p)
{
    return (mukca_page){.robot = p->fleet->model.robot,
                        .kind = "fleet report",
                        .from = p->fleet->model.base,
                        .to = p->fleet->model.tip,
                        .when = p->when,
                        .open = open_page,
                        .sections = sections,
                        .n_sections = sizeof sections / sizeof *sections,
                        .content = p};
}
