/* The report of a fleet: verdict, outliers, coefficients, ripple, provenance. */
#include "report/fleet_page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report/html.h"
#include "report/page.h"
#include "report/wording_fleet.h"

enum { MOST_ROWS = 200 }; /* largest number of rows of a table */
static const double per = MUKCA_WORDING_PER_SPRING;

/* ---- the order of the page ---- */

static int by_departure(const void *a, const void *b)
{
    const mukca_departure *x = a, *y = b;
    if (x->probability != y->probability) return x->probability < y->probability ? 1 : -1;
    if (x->log_bayes_factor != y->log_bayes_factor)
        return x->log_bayes_factor < y->log_bayes_factor ? 1 : -1;
    return x->arm - y->arm;
}

mukca_status mukca_fleet_page_prepare(mukca_fleet_page *p, mukca_error *error)
{
    const mukca_fleet_result *r = p->result;
    const size_t n = (size_t)p->fleet->n_arms;
    p->arms = malloc(n * sizeof *p->arms);
    if (!p->arms) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the page");
    memcpy(p->arms, r->departure, n * sizeof *p->arms);
    qsort(p->arms, n, sizeof *p->arms, by_departure);
    while (p->n_departing < (int)n && p->arms[p->n_departing].probability >= MUKCA_DEPARTS)
        p->n_departing++;
    bool departs[MUKCA_FLEET_TERMS] = {false};
    for (int i = 0; i < p->n_departing; i++) departs[p->arms[i].k] = true;
    int next = 0;
    for (int rank = 0; rank < 3; rank++)
        for (int k = 0; k < r->population.n; k++)
            if (rank == (departs[k] ? 0 : r->traits.list[k].probability >= MUKCA_SHARED ? 1 : 2))
                p->panels[next++] = k;
    return MUKCA_OK;
}

void mukca_fleet_page_free(mukca_fleet_page *p)
{
    free(p->arms);
    p->arms = NULL;
}

/* ---- verdict and what to do ---- */

static void put_departure(FILE *out, const mukca_fleet_page *p, const mukca_departure *d)
{
    char words[MUKCA_WORDING];
    mukca_wording_fleet_departure(words, d, p->fleet);
    mukca_html_escape(out, p->fleet->arm[d->arm].name);
    fputs(": ", out);
    mukca_html_escape(out, words);
}

static void put_verdict(FILE *out, const mukca_fleet_page *p)
{
    const mukca_fleet *f = p->fleet;
    fprintf(out, "<p class=\"verdict %s\">",
            p->n_departing  ? "unknown"
            : f->n_arms < 3 ? "untestable"
                            : "none");
    if (p->n_departing == 1)
        put_departure(out, p, &p->arms[0]);
    else if (p->n_departing)
        fprintf(out, "%d of %d arms depart from the fleet", p->n_departing, f->n_arms);
    else
        fputs(f->n_arms < 3 ? "Departures are not testable with two arms"
                            : "No arm departs from the fleet",
              out);
    fputs(".</p>\n", out);
    if (p->n_departing < 2) return;
    fputs("<ul>\n", out);
    for (int i = 0; i < p->n_departing && i < MOST_ROWS; i++) {
        fputs("<li>", out);
        put_departure(out, p, &p->arms[i]);
        fputs("</li>\n", out);
    }
    fputs("</ul>\n", out);
}

/* List the shared coefficients and orders. */
static void put_shared(FILE *out, const mukca_fleet_page *p)
{
    const mukca_traits *t = &p->result->traits;
    int n = 0;
    fputs("<h2 id=\"shared\">What the arms share</h2>\n<ul>\n", out);
    for (int i = 0; i < t->n; i++) {
        char words[MUKCA_WORDING];
        if (t->list[i].probability < MUKCA_SHARED) continue;
        mukca_wording_fleet_trait(words, &t->list[i], p->fleet);
        mukca_html_element(out, "li", words);
        n++;
    }
    fputs(n ? "</ul>\n" : "<li>no elastic coefficient and no order of ripple</li></ul>\n", out);
}

static void put_to_do(FILE *out, const mukca_fleet_page *p)
{
    fputs("<h2 id=\"to-do\">What to do</h2>\n<ul>\n", out);
    for (int i = 0; i < p->n_departing && i < MOST_ROWS; i++) {
        const char *remedy = mukca_effect_table[p->arms[i].effect.kind]->remedy;
        fputs("<li>", out);
        mukca_html_escape(out, p->fleet->arm[p->arms[i].arm].name);
        fputs(": ", out);
        mukca_html_escape(out, remedy ? remedy : "inspect the transmission");
        fputs("</li>\n", out);
    }
    fputs("<li>", out);
    mukca_html_sentence(out,
                        "`mukca fleet` with these summaries and `-o MODEL.traits.tsv` saves what "
                        "the arms share as prior for `diagnose --traits` and `calibrate --traits`");
    fputs(".</li>\n</ul>\n", out);
}

static void put_key_figures(FILE *out, const mukca_fleet_page *p)
{
    const struct {
        const char *label;
        int value;
    } tiles[] = {{"arms", p->fleet->n_arms},
                 {"arms that depart", p->n_departing},
                 {"sessions", p->fleet->n_sessions},
                 {"samples", p->result->traits.n_samples}};
    fputs("<dl class=\"tiles\">\n", out);
    for (int i = 0; i < 4; i++)
        fprintf(out, "<div><dt>%s</dt><dd>%d</dd></div>\n", tiles[i].label, tiles[i].value);
    fputs("</dl>\n", out);
}

/* ---- tables ---- */

static void put_arms(FILE *out, const mukca_fleet_page *p)
{
    const int n = p->fleet->n_arms;
    char words[MUKCA_WORDING];
    mukca_html_table table = {
        .out = out,
        .caption = "Arms by the probability of a departure, " MUKCA_WORDING_SPRING,
        .columns =
            "arm|#sessions|#samples|largest departure|#value|#from|#to|#sisters|#probability"};
    for (int i = 0; i < n && i < MOST_ROWS; i++) {
        const mukca_departure *d = &p->arms[i];
        const mukca_fleet_arm *arm = &p->fleet->arm[d->arm];
        if (d->k < 0) {
            mukca_html_row(&table, "%s\t%d\t%d\tnot testable\tnan\tnan\tnan\tnan\tnan", arm->name,
                           arm->end - arm->first, arm->samples);
            continue;
        }
        mukca_wording_fleet_effect(words, &d->effect, p->fleet);
        mukca_html_row(&table, "%s\t%d\t%d\t%s\t%.3g\t%.3g\t%.3g\t%.3g\t%.3f", arm->name,
                       arm->end - arm->first, arm->samples, words, per * fmax(d->value, 0),
                       per * d->low, per * fmax(d->high, 0), per * d->mean, d->probability);
    }
    mukca_html_table_end(&table);
    if (n > MOST_ROWS) fprintf(out, "<p>The first %d of %d arms.</p>\n", MOST_ROWS, n);
}

static void put_coefficients(FILE *out, const mukca_fleet_page *p)
{
    const mukca_fleet_result *r = p->result;
    char words[MUKCA_WORDING];
    mukca_html_table table = {
        .out = out,
        .caption = "Elastic coefficients of the fleet, " MUKCA_WORDING_SPRING,
        .columns =
            "coefficient|#mean|#from|#to|#spread|#arms|#log Bayes factor|#probability shared"};
    for (int i = 0; i < r->population.n; i++) {
        const mukca_trait *s = &r->traits.list[p->panels[i]];
        mukca_wording_fleet_effect(words, &s->effect, p->fleet);
        mukca_html_row(&table, "%s\t%.3g\t%.3g\t%.3g\t%.3g\t%d\t%.1f\t%.3f", words, per * s->value,
                       per * s->low, per * s->high, per * s->spread, s->arms, s->log_bayes_factor,
                       s->probability);
    }
    mukca_html_table_end(&table);
}

static void put_orders(FILE *out, const mukca_fleet_page *p)
{
    mukca_html_table table = {
        .out = out,
        .caption = "Most probable order of each joint",
        .columns =
            "joint|#order, per turn|#arms that favour it|#log Bayes factor|#probability "
            "shared"};
    for (int j = 0; j < p->fleet->model.n_joints; j++) {
        const mukca_trait *o = &p->result->order[j];
        if (!o->effect.variant.order) continue;
        mukca_html_row(&table, "%s\t%d\t%d\t%.1f\t%.3f", p->fleet->model.joint[j],
                       o->effect.variant.order, o->arms, o->log_bayes_factor, o->probability);
    }
    mukca_html_table_end(&table);
}

static void put_provenance(FILE *out, const mukca_fleet_page *p)
{
    const int n = p->fleet->n_sessions;
    fputs("<p>Made by ", out);
    mukca_html_element(out, "code", p->command);
    fprintf(out, " at %s.</p>\n", p->when);
    mukca_html_table table = {
        .out = out, .caption = "Sessions", .columns = "arm|summary|recording|#samples|#noise, mm"};
    for (int s = 0; s < n && s < MOST_ROWS; s++) {
        const mukca_fleet_session *session = &p->fleet->session[s];
        mukca_html_row(&table, "%s\t%s\t%016llx\t%d\t%.3g", session->arm, session->path,
                       (unsigned long long)session->data, session->samples, 1e3 * session->sigma_m);
    }
    mukca_html_table_end(&table);
    if (n > MOST_ROWS) fprintf(out, "<p>The first %d of %d sessions.</p>\n", MOST_ROWS, n);
}

/* ---- sections ---- */

static const struct {
    const char *id, *heading;
    mukca_fleet_figure *figure; /* NULL: none */
    void (*text)(FILE *out, const mukca_fleet_page *page);
} sections[] = {
    {"arms", "Arms", NULL, put_arms},
    {"coefficients", "Elastic coefficients, arm by arm", mukca_fleet_draw_coefficient,
     put_coefficients},
    {"ripple", "Transmission ripple", mukca_fleet_draw_orders, put_orders},
    {"provenance", "Provenance", NULL, put_provenance},
};
enum { SECTIONS = sizeof sections / sizeof *sections };

static mukca_status put_figures(const mukca_page_figures *to, int section,
                                const mukca_fleet_page *p, mukca_error *error)
{
    mukca_status status = MUKCA_OK;
    bool more = sections[section].figure != NULL;
    for (int i = 0; more && status == MUKCA_OK; i++) {
        mukca_plot plot;
        status = mukca_plot_open(&plot, error);
        more = status == MUKCA_OK && sections[section].figure(&plot, p, i);
        if (more) status = mukca_page_figure(to, &plot, error);
        mukca_plot_free(&plot);
    }
    return status;
}

mukca_status mukca_fleet_page_write(FILE *out, const mukca_fleet_page *p, mukca_error *error)
{
    const mukca_fleet_model *model = &p->fleet->model;
    const mukca_page_figures page = {.page = out};
    mukca_page_begin(out, &(mukca_page_head){.robot = model->robot,
                                             .kind = "fleet report",
                                             .from = model->base,
                                             .to = model->tip,
                                             .when = p->when});
    put_verdict(out, p);
    put_shared(out, p);
    put_to_do(out, p);
    put_key_figures(out, p);
    fputs("<nav aria-label=\"Sections\"><ul>\n", out);
    for (int k = 0; k < SECTIONS; k++)
        fprintf(out, "<li><a href=\"#%s\">%s</a></li>\n", sections[k].id, sections[k].heading);
    fputs("</ul></nav>\n", out);
    for (int k = 0; k < SECTIONS; k++) {
        fprintf(out, "<section aria-labelledby=\"%s\">\n<h2 id=\"%s\">%s</h2>\n", sections[k].id,
                sections[k].id, sections[k].heading);
        if (sections[k].figure) fputs("<div class=\"figures\">\n", out);
        const mukca_status status = put_figures(&page, k, p, error);
        if (status != MUKCA_OK) return status;
        if (sections[k].figure) fputs("</div>\n", out);
        sections[k].text(out, p);
        fputs("</section>\n", out);
    }
    mukca_page_end(out);
    return MUKCA_OK;
}

mukca_status mukca_fleet_page_write_figures(const char *directory, const char *format,
                                            const mukca_fleet_page *p, mukca_error *error)
{
    const mukca_page_figures files = {.directory = directory, .format = format};
    mukca_status status = MUKCA_OK;
    for (int k = 0; k < SECTIONS && status == MUKCA_OK; k++)
        status = put_figures(&files, k, p, error);
    return status;
}
