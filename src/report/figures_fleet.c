/* Figures of a fleet: arms side by side for each coefficient, pooled ripple spectra. */
#include <math.h>

#include "base/utf8.h"
#include "report/fleet_page.h"
#include "report/wording_fleet.h"

enum {
    MOST_ARMS = 24, /* as many names as fit a figure */
    NAME = 12       /* characters of an arm's name */
};
static const double per = MUKCA_WORDING_PER_SPRING;

/* Print the arms' coefficients as blocks $sound and $departing, with their names as tics. */
static int put_arms(FILE *s, const mukca_fleet_page *p, int k)
{
    const mukca_fleet_result *r = p->result;
    const int shown = p->fleet->n_arms < MOST_ARMS ? p->fleet->n_arms : MOST_ARMS;
    int drawn = 0;
    for (int departing = 0; departing < 2; departing++) {
        fprintf(s, "$%s << EOD\n", departing ? "departing" : "sound");
        for (int i = 0; i < shown; i++) {
            const mukca_departure *d = &p->arms[i], *e = &r->estimate[d->arm * r->population.n + k];
            const bool departs = d->k == k && i < p->n_departing;
            if (d->k < 0 || departs != departing) continue;
            fprintf(s, "%d %.6g %.6g %.6g\n", i + 1, per * fmax(e->value, 0), per * e->low,
                    per * fmax(e->high, 0)); /* estimates may be negative */
            drawn++;
        }
        /* gnuplot reports a block without points as an error */
        fputs("0 0 0 0\nEOD\n", s);
    }
    fputs("set xtics rotate by -50 (", s);
    for (int i = 0; i < shown; i++) {
        const char *name = p->fleet->arm[p->arms[i].arm].name;
        char text[NAME + 1];
        snprintf(text, sizeof text, "%.*s", (int)mukca_utf8_fit(name, NAME), name);
        fputs(i ? ", " : "", s);
        mukca_plot_tic(s, text);
        fprintf(s, " %d", i + 1);
    }
    fputs(")\n", s);
    return drawn;
}

bool mukca_fleet_draw_coefficient(mukca_plot *plot, const mukca_fleet_page *p, int index)
{
    const mukca_fleet_result *r = p->result;
    if (index >= r->population.n) return false;
    const int k = p->panels[index], n = p->fleet->n_arms, shown = n < MOST_ARMS ? n : MOST_ARMS;
    const mukca_trait *c = &r->traits.list[k];
    char words[MUKCA_WORDING], id[64], title[160];
    FILE *s = plot->script;
    mukca_wording_fleet_effect(words, &c->effect, p->fleet);
    snprintf(id, sizeof id, "coefficient-%d", index + 1);
    snprintf(title, sizeof title, "%.150s", words);
    mukca_plot_begin(plot, id, title, MUKCA_PLOT_HALF, 260);
    const int drawn = put_arms(s, p, k);
    if (!drawn) return false;
    fprintf(
        s,
        "set xrange [0.3:%g]\nset yrange [0:*]\nset ylabel '" MUKCA_WORDING_SPRING
        "'\nset object rectangle from graph 0, first %.6g to graph 1, first %.6g behind "
        "fillcolor rgb 'gray' fillstyle transparent solid 0.35 noborder\n"
        "set arrow from graph 0, first %.6g to graph 1, first %.6g nohead linecolor rgb "
        "'black' dashtype 2\n"
        "plot $sound using 1:2:3:4 with yerrorbars lc rgb " PLOT_AFTER
        " pt 7 ps 0.6 lw 1.5 notitle, $departing using 1:2:3:4 with yerrorbars lc rgb " PLOT_BEFORE
        " pt 9 ps 0.9 lw 2 notitle\n",
        shown + 0.7, per * fmax(c->value - 1.96 * c->spread, 0),
        per * (c->value + 1.96 * c->spread), per * c->value, per * c->value);
    fprintf(plot->description,
            "Each arm with its 95 %% interval, its sisters as prior; dashed: mean of the fleet, "
            "%.3g [%.3g, %.3g]; grey: range of 95 %% of its arms.",
            per * c->value, per * c->low, per * c->high);
    for (int i = 0; i < p->n_departing; i++)
        if (i < MOST_ARMS && p->arms[i].k == k)
            fprintf(plot->description, " %s departs: %.3g [%.3g, %.3g].",
                    p->fleet->arm[p->arms[i].arm].name, per * p->arms[i].value,
                    per * p->arms[i].low, per * p->arms[i].high);
    if (shown < n)
        fprintf(plot->description, " The %d of %d arms that are most probable to depart.", shown,
                n);
    return true;
}

bool mukca_fleet_draw_orders(mukca_plot *plot, const mukca_fleet_page *p, int index)
{
    const mukca_trait *order = p->result->order;
    int joint = 0;
    for (int seen = -1; joint < p->fleet->model.n_joints; joint++)
        if (order[joint].effect.variant.order && ++seen == index) break;
    if (joint == p->fleet->model.n_joints) return false;
    const mukca_trait *best = &order[joint];
    const int number = best->effect.variant.order;
    const bool shared = best->probability >= MUKCA_SHARED;
    const char *name = p->fleet->model.joint[joint];
    char id[64], title[160], probability[MUKCA_WORDING];
    int favoured = 0;
    double most = 0;
    FILE *s = plot->script;
    snprintf(id, sizeof id, "orders-%d", joint + 1);
    snprintf(title, sizeof title, "Transmission ripple of %s, pooled", name);
    mukca_plot_begin(plot, id, title, MUKCA_PLOT_HALF, 240);
    fputs("$d << EOD\n", s);
    for (int o = 2; o < MUKCA_FLEET_ORDERS + 2; o++) {
        double pooled = 0;
        for (int a = 0; a < p->fleet->n_arms; a++)
            pooled += mukca_fleet_ripple(p->fleet, a, joint, o);
        fprintf(s, "%d %.6g %d\n", o, pooled, shared && o == number);
        favoured += pooled > 0;
        most = fmax(most, pooled);
    }
    const double top = fmax(1.25 * most, 10); /* noise remains small; room for evidence against */
    fprintf(s,
            "EOD\nset xrange [0:%d]\nset yrange [%.6g:%.6g]\nset xzeroaxis lc rgb "
            "'black' lw 0.6\nset xlabel 'order, per turn'\n"
            "set ylabel 'log Bayes factor'\n",
            MUKCA_FLEET_ORDERS + 5, -0.4 * top, top);
    if (best->log_bayes_factor > 0)
        fprintf(s, "set label '%d' at %d, %.6g center offset 0, 0.6\n", number, number,
                best->log_bayes_factor);
    fputs("plot $d using 1:2 with impulses lc rgb " PLOT_AFTER
          " lw 1.5 notitle, $d using 1:($3 > 0 ? $2 : NaN) with impulses lc rgb " PLOT_BEFORE
          " lw 3 notitle\n",
          s);
    mukca_wording_probability(probability, best->probability);
    if (favoured)
        fprintf(plot->description,
                "Sum of the log Bayes factors of all arms; %d of %d orders are favoured. Most "
                "probable: order %d, log Bayes factor %.3g, %s.",
                favoured, MUKCA_FLEET_ORDERS, number, best->log_bayes_factor,
                shared ? probability : "not shared");
    else
        fprintf(plot->description,
                "Sum of the log Bayes factors of all arms: the evidence is against each of the "
                "orders 2 to %d.",
                MUKCA_FLEET_ORDERS + 1);
    return true;
}
