/* The report of a fleet: its wording; verdict, departing arms, coefficients arm by arm, ripple. */
#include "report/report.h"

#include <math.h>

#include "math/stats.h"
#include "report/page.h"

enum {
    MOST_ROWS = 200, /* largest number of rows of a table */
    MOST_ARMS = 24   /* likewise, of a coefficient */
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

static void put_departures(FILE *out, const mukca_fleet *f, int n)
{
    char words[MUKCA_WORDING];
    for (int i = 0; i < n && i < MOST_ROWS; i++) {
        const mukca_departure *d = &f->ranked[i];
        const char *remedy = mukca_effect_table[d->effect.kind]->remedy;
        mukca_wording_fleet_departure(words, d, f);
        fputs("<li>", out);
        mukca_html_escape(out, n > 1 ? words : f->arm[d->arm].name);
        fputs(": ", out);
        mukca_html_escape(out, remedy ? remedy : "inspect the transmission");
        fputs("</li>\n", out);
    }
}

/* Verdict, shared properties, and what to do. */
static void open_page(FILE *out, const void *content)
{
    const mukca_fleet *f = content;
    const mukca_traits *t = &f->traits;
    char words[MUKCA_WORDING] = "No arm departs from the fleet";
    int n = 0, shared = 0;
    for (int a = 0; a < f->n_arms; a++) n += departs(&f->arm[a].departure);
    if (n > 1) snprintf(words, sizeof words, "%d of %d arms depart from the fleet", n, f->n_arms);
    if (n == 1) mukca_wording_fleet_departure(words, f->ranked, f);
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
    put_departures(out, f, n);
    mukca_html_sentence(out, "<li>",
                        "`mukca fleet` with these summaries and `-o MODEL.traits.tsv` saves what "
                        "the arms share as prior for `diagnose --traits` and `calibrate --traits`",
                        ".</li>\n</ul>\n");
}

/* A coefficient of the arms side by side. */
static void put_coefficient(FILE *out, const mukca_fleet *f, int k)
{
    const mukca_trait *c = &f->traits.list[k];
    const double spread = MUKCA_SIGMAS_95 * c->spread;
    const int n = f->n_arms < MOST_ARMS ? f->n_arms : MOST_ARMS;
    char caption[2 * MUKCA_WORDING], words[MUKCA_WORDING], probability[MUKCA_WORDING];
    mukca_html_table table = {
        .out = out, .caption = caption, .columns = "arm|#value|bar|#from|#to|#departs"};
    double most = 0;
    put_effect(words, &c->effect, f);
    snprintf(caption, sizeof caption,
             "%s, " MUKCA_WORDING_SPRING
             ": mean %.3g [%.3g, %.3g] if shared (%s), 95 %% of the arms from %.3g to %.3g",
             words, per * c->value, per * c->low, per * c->high,
             mukca_wording_probability(probability, c->probability),
             per * fmax(c->value - spread, 0), per * (c->value + spread));
    for (int i = 0; i < n; i++) most = fmax(most, f->arm[f->ranked[i].arm].estimate[k].high);
    for (int i = 0; i < n; i++) {
        const mukca_fleet_arm *arm = &f->arm[f->ranked[i].arm];
        const mukca_departure *e = &arm->estimate[k];
        const double value = fmax(e->value, 0); /* estimates may be negative */
        if (f->ranked[i].k >= 0)
            mukca_html_row(&table, "%s\t%.3g\t%.0f\t%.3g\t%.3g\t%.3f", arm->name, per * value,
                           most > 0 ? 100 * value / most : 0, per * fmax(e->low, 0),
                           per * fmax(e->high, 0), e->probability);
    }
    mukca_html_table_end(&table);
}

static void put_coefficients(FILE *out, const void *content)
{
    const mukca_fleet *f = content;
    fputs(f->n_arms < 3 ? "<p>Not testable with two arms."
                        : "<p>Each arm with its 95 % interval, its sisters as prior, and the "
                          "probability that this coefficient departs from theirs.",
          out);
    if (f->n_arms > MOST_ARMS)
        fprintf(out, " The %d of %d arms that are most probable to depart.", MOST_ARMS, f->n_arms);
    fputs("</p>\n<div class=\"pairs\">\n", out);
    for (int k = 0; k < f->population.n; k++) put_coefficient(out, f, k);
    fputs("</div>\n", out);
}

static const mukca_page_section sections[] = {
    {"coefficients", "Elastic coefficients, arm by arm", put_coefficients},
};

mukca_page mukca_fleet_page(const mukca_fleet *f)
{
    return (mukca_page){.robot = f->model.robot,
                        .kind = "fleet report",
                        .from = f->model.base,
                        .to = f->model.tip,
                        .open = open_page,
                        .sections = sections,
                        .n_sections = sizeof sections / sizeof *sections,
                        .content = f};
}
