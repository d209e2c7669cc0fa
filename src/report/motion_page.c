/* The page of a motion. */
#include "report/motion_page.h"

#include <math.h>

#include "motion/torques.h"
#include "report/wording_motion.h"

#define put mukca_wording_put /* short for this file */

/* Samples: half a figure's width in px in succession, and as many marks as stay distinct. */
enum { START = 420, EVEN = 300 };

/* ---- torques ---- */

typedef struct {
    mukca_motion_trace *out;
    const mukca_torques *t;
    double *error[2][MUKCA_MAX_JOINTS]; /* raw coefficients of model and fit, minus the measured */
    double *x, *Y;
} tracer;

static void add_sample(tracer *r, const mukca_stretch *s, int i)
{
    mukca_motion_trace *out = r->out;
    const mukca_torques *t = r->t;
    const int n = t->n, at = out->n * n;
    const double still[MUKCA_MAX_JOINTS] = {0}, *q = s->q + i * n, *dq = s->dq + i * n;
    double gravity[MUKCA_MAX_JOINTS];
    const mukca_raw_block block = {s, i, i + 1, r->Y, gravity};
    mukca_dynamics_regressor(r->Y, &t->model.dynamics, q, dq, s->ddq + i * n);
    mukca_dynamics_torque(gravity, &t->model.dynamics, t->model.load, q, still, still);
    for (int j = 0; j < n; j++) {
        const int width = mukca_raw_width(n, j);
        mukca_raw_fill(r->x, width, &t->model, &block, j);
        out->q[at + j] = q[j], out->dq[at + j] = dq[j];
        for (int k = 0; k < MUKCA_TRACES; k++) {
            out->torque[k][at + j] = s->torque[i * n + j];
            for (int c = 0; c < width && k; c++)
                out->torque[k][at + j] += r->error[k - 1][j][c] * r->x[c];
        }
    }
    out->time[out->n++] = s->start + i * t->model.signals->dt;
}

/* Coefficients of the columns of the fit, which end in the value. */
static bool find_errors(tracer *r, mukca_pool *pool, const mukca_torque_columns *c)
{
    const mukca_torques *t = r->t;
    double *mean = MUKCA_TAKE(pool, double, c->n);
    for (int j = 0; j < t->n; j++)
        for (int k = 0; k < 2; k++)
            r->error[k][j] = MUKCA_TAKE(pool, double, mukca_raw_width(t->n, j));
    if (pool->failed || !mukca_torques_fit(mean, t, c, &mukca_torques_whole)) return false;
    for (int k = 0; k < c->n; k++)
        for (int i = t->items.first[c->column[k]]; i < t->items.first[c->column[k] + 1]; i++) {
            const mukca_raw_term *of = &t->items.term[i];
            r->error[1][of->joint][of->raw] += mean[k] * c->factor[k] * of->weight;
            if (k + 1 == c->n) r->error[0][of->joint][of->raw] -= of->weight;
        }
    return true;
}

bool mukca_motion_trace_make(mukca_motion_trace *out, mukca_pool *pool, const mukca_torques *t,
                             const mukca_torque_columns *fitted)
{
    const mukca_signals *s = t->model.signals;
    const int most = START + EVEN, n = t->n;
    mukca_pool scratch = {0};
    tracer r = {.out = out,
                .t = t,
                .x = MUKCA_TAKE(&scratch, double, mukca_raw_width(n, 0)),
                .Y = MUKCA_TAKE(&scratch, double, n *n *MUKCA_INERTIAL)};
    *out = (mukca_motion_trace){.n_joints = n,
                                .time = MUKCA_TAKE(pool, double, most),
                                .q = MUKCA_TAKE(pool, double, most *n),
                                .dq = MUKCA_TAKE(pool, double, most *n)};
    for (int k = 0; k < MUKCA_TRACES; k++) out->torque[k] = MUKCA_TAKE(pool, double, most *n);
    bool ok = find_errors(&r, &scratch, fitted) && !pool->failed;
    long samples = 0, at = 0;
    for (const mukca_stretch *k = s->stretch; k < s->stretch + s->n && ok; k++) {
        if (k->role != MUKCA_RUN_NEW) continue;
        for (int i = 0; i < k->n && i < START && samples == 0; i++) add_sample(&r, k, i);
        samples += k->n;
    }
    out->n_start = out->n;
    for (const mukca_stretch *k = s->stretch; k < s->stretch + s->n && ok; k++)
        for (int i = 0; i < k->n && k->role == MUKCA_RUN_NEW; i++, at++)
            if ((out->n - out->n_start) * samples <= at * EVEN && out->n < most)
                add_sample(&r, k, i);
    mukca_pool_free(&scratch);
    return ok;
}

/* ---- figures ---- */

enum { OVER_ANGLE, OVER_VELOCITY, FIGURES };

static double rms(const mukca_motion_trace *t, int joint, int of)
{
    double sum = 0;
    for (int i = t->n_start; i < t->n; i++)
        sum += pow(t->torque[of][i * t->n_joints + joint] -
                       t->torque[MUKCA_TRACE_MEASURED][i * t->n_joints + joint],
                   2);
    return sqrt(sum / fmax(t->n - t->n_start, 1));
}

static void put_time(FILE *out, const mukca_motion_report *r, int j)
{
    static const mukca_plot_series series[MUKCA_TRACES] = {MUKCA_PLOT_MEASURED, MUKCA_PLOT_BEFORE,
                                                           MUKCA_PLOT_AFTER};
    const mukca_motion_trace *t = r->trace;
    const char *name = mukca_chain_joint_name(r->chain, j);
    mukca_plot plot = {
        .id = put(MUKCA_WORDS, "time-%d", j + 1),
        .title = put(MUKCA_WORDS, "Torque of %s over time", name),
        .label = {"time, s", "torque, N m"},
        .words = put(MUKCA_WORDS,
                     "The measured torque of %s, that of the model, and that of the model with its "
                     "parameters and the findings fitted, at the start of the first run.",
                     name),
        .key = {[MUKCA_PLOT_AFTER] = "with findings",
                [MUKCA_PLOT_BEFORE] = "model",
                [MUKCA_PLOT_MEASURED] = "measured"},
        .points = r->points,
        .lines = true};
    for (int k = 0; k < MUKCA_TRACES; k++)
        for (int i = 0; i < t->n_start; i++)
            plot.points[plot.n_points++] =
                (mukca_plot_point){series[k], {t->time[i], t->torque[k][i * t->n_joints + j]}};
    mukca_plot_put(out, &plot);
}

static void put_errors(FILE *out, const mukca_motion_report *r, int j, int over)
{
    const mukca_motion_trace *t = r->trace;
    const char *name = mukca_chain_joint_name(r->chain, j),
               *what = over == OVER_ANGLE ? "angle" : "velocity";
    const double *x = over == OVER_ANGLE ? t->q : t->dq;
    mukca_plot plot = {
        .id = put(MUKCA_WORDS, "%s-%d", what, j + 1),
        .title = put(MUKCA_WORDS, "Torque error of %s over its %s", name, what),
        .label = {over == OVER_ANGLE ? "angle, rad" : "velocity, rad/s",
                  "model minus measured, N m"},
        .words = put(MUKCA_WORDS,
                     "The error of the torque of %s over its %s: %.3g N m rms of the model, %.3g N "
                     "m with the findings.",
                     name, what, rms(t, j, MUKCA_TRACE_MODEL), rms(t, j, MUKCA_TRACE_FITTED)),
        .key = {[MUKCA_PLOT_AFTER] = "with findings", [MUKCA_PLOT_BEFORE] = "model"},
        .points = r->points};
    for (int k = MUKCA_TRACE_MODEL; k < MUKCA_TRACES; k++)
        for (int i = t->n_start; i < t->n; i++) {
            const int at = i * t->n_joints + j;
            plot.points[plot.n_points++] =
                (mukca_plot_point){k == MUKCA_TRACE_MODEL ? MUKCA_PLOT_BEFORE : MUKCA_PLOT_AFTER,
                                   {x[at], t->torque[k][at] - t->torque[MUKCA_TRACE_MEASURED][at]}};
        }
    mukca_plot_put(out, &plot);
}

static void put_torques(FILE *out, const void *content)
{
    const mukca_motion_report *r = content;
    fputs("<div class=\"figures\">\n", out);
    for (int j = 0; j < r->trace->n_joints; j++) put_time(out, r, j);
    fputs("</div>\n", out);
}

static void put_residuals(FILE *out, const void *content)
{
    const mukca_motion_report *r = content;
    const mukca_motion_trace *t = r->trace;
    fputs("<div class=\"figures\">\n", out);
    for (int j = 0; j < t->n_joints; j++)
        for (int over = 0; over < FIGURES; over++) put_errors(out, r, j, over);
    fputs("</div>\n", out);
}

/* ---- findings ---- */

static void put_findings(FILE *out, const void *content)
{
    const mukca_motion_report *r = content;
    const mukca_motion *m = r->motion;
    mukca_html_table table = {
        .out = out,
        .caption =
            "Findings, the largest first: torque at the joint where it is the largest part "
            "of the range, rms",
        .style = "cards",
        .columns = "finding|#torque, N m|#% of the range|certainty|alternatives"};
    for (int i = 0; i < m->n_findings + m->n_maybe; i++) {
        const bool sure = i < m->n_findings;
        const mukca_motion_finding *f = sure ? &m->finding[i] : &m->maybe[i - m->n_findings];
        const char *certainty =
            sure ? mukca_wording_torque_certainty(MUKCA_WORDS, f)
                 : put(MUKCA_WORDS, "maybe, %.0f %%", 100 * f->group.probability);
        mukca_html_row(&table, "%s\t%.3g\t%.1f\t%s\t%s",
                       mukca_wording_torque(MUKCA_WORDS, &f->group, r->chain), f->size_nm.value,
                       f->size_percent, certainty,
                       mukca_wording_torque_alternatives(MUKCA_WORDS, f, r->chain));
    }
    mukca_html_table_end(&table);
    table = (mukca_html_table){
        .out = out,
        .caption = "Held-out torque error, N m rms",
        .columns = "joint|#model|#parameters fitted|#with findings|#noise|#range"};
    for (int j = 0; j < m->n_joints; j++) {
        const mukca_motion_joint *of = &m->joint[j];
        mukca_html_row(&table, "%s\t%.3g\t%.3g\t%.3g\t%.3g\t%.3g",
                       mukca_chain_joint_name(r->chain, j), of->nominal_nm, of->baseline_nm,
                       of->explained_nm, of->floor_nm, of->range_nm);
    }
    mukca_html_table_end(&table);
}

static void open_page(FILE *out, const void *content)
{
    const mukca_motion_report *r = content;
    const mukca_motion *m = r->motion;
    fprintf(out, "<p class=\"verdict %s\">", mukca_motion_verdict_name[m->verdict]);
    mukca_html_sentence(
        out, "",
        m->n_findings    ? mukca_wording_torque(MUKCA_WORDS, &m->finding[0].group, r->chain)
        : m->n_reference ? "These runs agree with the reference"
                         : "Nothing was found beyond the uncertainty of the model's parameters",
        "");
    if (m->n_findings > 1)
        fprintf(out, ", and %d further finding%s", m->n_findings - 1, m->n_findings > 2 ? "s" : "");
    fprintf(out, ".</p>\n<p>%s.</p>\n", mukca_wording_runs(MUKCA_WORDS, m));
}

static const mukca_page_section sections[] = {
    {"findings", "Findings", put_findings},
    {"torques", "Torques over time", put_torques},
    {"residuals", "Torque errors over angle and velocity", put_residuals},
};

mukca_page mukca_motion_page(const mukca_motion_report *r)
{
    return (mukca_page){.robot = r->chain->robot,
                        .kind = "motion report",
                        .from = r->chain->base,
                        .to = r->chain->tip,
                        .open = open_page,
                        .sections = sections,
                        .n_sections = sizeof sections / sizeof *sections,
                        .content = r};
}
