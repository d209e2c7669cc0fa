/* The report of a fleet: its wording; verdict, departing arms, coefficients arm by arm, ripple. */
#include "report/report.h"

#include <math.h>

#include "math/stats.h"

#define put mukca_wording_put /* short for this file */

enum {
    MOST_ROWS = 200, /* largest number of rows of a table */
    MOST_ARMS = 24   /* likewise, of a coefficient */
};

/* Unit of all coefficients, and their factor from rad/(N m). */
#define SPRING "urad/(N·m)"
static const double per = 1e6;

/* ---- wording, shared with the screen ---- */

static const char *name_effect(char text[MUKCA_WORDING], const mukca_effect *e,
                               const mukca_fleet *f)
{
    return mukca_wording_effect(text, e->kind, e->joint < 0 ? NULL : f->model.joint[e->joint]);
}

const char *mukca_wording_fleet_trait(char text[MUKCA_WORDING], const mukca_trait *t,
                                      const mukca_fleet *f)
{
    const char *effect = name_effect(MUKCA_WORDS, &t->effect, f),
               *probability = mukca_wording_probability(MUKCA_WORDS, t->probability);
    if (t->effect.variant.order)
        return put(text, "%s, %d per turn, seen in %d of %d arms, %s", effect,
                   t->effect.variant.order, t->arms, f->n_arms, probability);
    return put(text, "%s, %.3g " SPRING " [%.3g, %.3g], arms differ by %.2g (%.0f %%), %s", effect,
               per * t->value, per * t->low, per * t->high, per * t->spread,
               100 * t->spread / t->value, probability);
}

const char *mukca_wording_fleet_departure(char text[MUKCA_WORDING], const mukca_departure *d,
                                          const mukca_fleet *f)
{
    put(text, "%s: %s ", f->arm[d->arm].name, name_effect(MUKCA_WORDS, &d->effect, f));
    if (!isfinite(d->ratio))
        put(text, "unlike");
    else if (d->ratio >= 1)
        put(text, "%.1f times softer than", d->ratio);
    else
        put(text, "stiffer (%.1f of the deflection) than", d->ratio);
    return put(text, " %d sisters, %.3g " SPRING " [%.3g, %.3g] against %.3g, %s", f->n_arms - 1,
               per * d->value, per * d->low, per * d->high, per * d->mean,
               mukca_wording_probability(MUKCA_WORDS, d->probability));
}

/* ---- texts ---- */

static void put_departures(FILE *out, const mukca_fleet *f, int n)
{
    for (int i = 0; i < n && i < MOST_ROWS; i++) {
        const mukca_departure *d = &f->ranked[i];
        const char *remedy = mukca_effect_table[d->effect.kind]->remedy;
        mukca_html_element(
            out, "li",
            put(MUKCA_WORDS, "%s: %s",
                n > 1 ? mukca_wording_fleet_departure(MUKCA_WORDS, d, f) : f->arm[d->arm].name,
                remedy ? remedy : "inspect the transmission"));
        fputc('\n', out);
    }
}

/* Verdict, shared properties, and what to do. */
static void open_page(FILE *out, const void *content)
{
    const mukca_fleet *f = content;
    const mukca_traits *t = &f->traits;
    int n = 0, shared = 0;
    for (int a = 0; a < f->n_arms; a++) n += f->ranked[a].probability >= MUKCA_DEPARTS;
    fprintf(out, "<p class=\"verdict %s\">", n ? "unknown" : f->n_arms < 3 ? "untestable" : "none");
    mukca_html_escape(
        out, f->n_arms < 3 ? "Departures are not testable with two arms"
             : n > 1       ? put(MUKCA_WORDS, "%d of %d arms depart from the fleet", n, f->n_arms)
             : n           ? mukca_wording_fleet_departure(MUKCA_WORDS, f->ranked, f)
                           : "No arm departs from the fleet");
    fprintf(out,
            ".</p>\n<p>%d arms, %d sessions, %d samples.</p>\n"
            "<h2 id=\"shared\">What the arms share</h2>\n<ul>\n",
            f->n_arms, f->n_sessions, t->n_samples);
    for (int i = 0; i < t->n; i++) {
        if (t->list[i].probability < MUKCA_SHARED) continue;
        mukca_html_element(out, "li", mukca_wording_fleet_trait(MUKCA_WORDS, &t->list[i], f));
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
    mukca_html_table table = {
        .out = out,
        .caption =
            put(MUKCA_WORDS,
                "%s, " SPRING
                ": mean %.3g [%.3g, %.3g] if shared (%s), 95 %% of the arms from %.3g to %.3g",
                name_effect(MUKCA_WORDS, &c->effect, f), per * c->value, per * c->low,
                per * c->high, mukca_wording_probability(MUKCA_WORDS, c->probability),
                per * fmax(c->value - spread, 0), per * (c->value + spread)),
        .columns = "arm|#value|bar|#from|#to|#departs"};
    double most = 0;
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
