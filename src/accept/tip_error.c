/* Expected error of the tip, from the posterior of geometry and effects. */
#include "accept/accept.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "accept/posterior.h"
#include "base/file.h"
#include "base/text.h"
#include "effect/catalogue.h"
#include "math/dense.h"
#include "math/stats.h"

/* Postures; arms from the posterior: a probability of 95 % is known to 1.5 %. */
enum { PROBES = 256, DRAWS = 200 };

/* Least log Bayes factor of effects that the table lacks: as for a detection limit
 * (diagnose/untested.c). */
static const double least_evidence = 12;

/* Ratio of a deviation to the noise, of which Student's weight is below 0.07; m, beyond any arm and
 * noise. */
static const double outlier = 10, gross_error = 0.1;

/* Of the logarithm of the ratio of the residuals' variances across and along the axis of a joint:
 * 1 % of 1200 joints that moved, in 200 recordings, are beyond twice this. */
static const double spread = 0.8;

/* Mean errors over the probes of each arm from the posterior, sum[0] before and sum[1] after; the
 * last scatter[DRAWS] is their mean square after. */
static bool sample(double sum[3][DRAWS], mukca_arm_posterior *p, const double *X,
                   mukca_random *random)
{
    const int n = p->m.linear.n_columns, w = MUKCA_RIGID + n + 3;
    const mukca_posterior *posterior = &p->m.evidence.posterior;
    double *Z = MUKCA_TAKE(&p->pool, double, n *DRAWS),
           *E = MUKCA_TAKE(&p->pool, double, 3 * DRAWS),
           *turned = MUKCA_TAKE(&p->pool, double, 3 * n);
    if (p->pool.failed) return false;
    for (int i = 0; i < n * DRAWS; i++) Z[i] = mukca_random_normal(random);
    mukca_dense_backward(Z, DRAWS, posterior->factor, n);
    for (int i = 0; i < n * DRAWS; i++) {
        const int k = i / DRAWS; /* the columns are those at the unknowns `explained` */
        Z[i] = Z[i] * posterior->prior[k] + p->m.evidence.mean[k] - p->m.linear.explained[k];
    }
    memset(sum, 0, sizeof(double[3][DRAWS]));
    for (int i = 0; i < PROBES; i++, X += 3 * w) {
        memset(E, 0, sizeof *E * 3 * DRAWS);
        for (int c = 0; c < 3 * n; c++) turned[c] = X[c % 3 * w + MUKCA_RIGID + c / 3];
        mukca_dense_xty(E, (mukca_columns){turned, 3, 3}, (mukca_columns){Z, DRAWS, DRAWS}, n);
        for (int k = 0; k < 2 * DRAWS; k++) {
            const int m = k / DRAWS, draw = k % DRAWS;
            double square = 0;
            for (int a = 0; a < 3; a++)
                square += pow(X[a * w + w - 2 + m] - E[a * DRAWS + draw], 2);
            sum[m][draw] += sqrt(square) / PROBES;
            if (m) sum[2][draw] += square / PROBES;
        }
    }
    return true;
}

/* Mean errors of both models over arms from the posterior, with the interval of the table's, for as
 * many other postures: both means scatter by the choice of theirs. */
static bool summarise(mukca_tip_error *out, int where, mukca_arm_posterior *p, const double *X,
                      mukca_random *random)
{
    double sum[3][DRAWS];
    if (!sample(sum, p, X, random)) return false;
    for (int k = 0; k < DRAWS; k++) {
        const double after = sum[1][k];
        out->before_m[where] += sum[0][k] / DRAWS;
        out->after_m[where] += after / DRAWS;
        out->probability[where] += (after < sum[0][k]) / (double)DRAWS;
        const double scatter = sqrt((sum[2][k] - after * after) / PROBES);
        out->scatter_m[where] += scatter / DRAWS;
        sum[1][k] += mukca_random_normal(random) * sqrt(2) * scatter;
    }
    out->low_m[where] = mukca_stats_quantile(sum[1], DRAWS, 0.025);
    out->high_m[where] = mukca_stats_quantile(sum[1], DRAWS, 0.975);
    return true;
}

/* Mean and factor of the posterior for the present priors. */
static void solve(mukca_arm_posterior *p)
{
    mukca_regression *m = &p->m;
    mukca_unknowns_prior(m->evidence.posterior.prior, &m->unknowns, -1);
    mukca_evidence_evaluate(&m->evidence, mukca_regression_collect(m, m->unknowns.family),
                            m->unknowns.sigma, m->evidence.mean);
}

/* Part of the error by that of the sockets' distances: the rest is the error if they were exact, as
 * the table takes them; so does the question whether it is an improvement. */
static bool split_distance(mukca_tip_error *out, mukca_arm_posterior *p, const double *X,
                           mukca_random *random)
{
    mukca_tip_error exact = {0};
    const double all = out->after_m[MUKCA_HERE];
    out->distance_m = NAN;
    out->exact_m = all;
    mukca_unknowns *u = &p->m.unknowns;
    if (!p->m.recording.n_pairs) return true;
    for (int k = u->first_artefact; k < u->n_geometry; k++) u->theta_prior[k] = 0;
    solve(p);
    const bool done = summarise(&exact, MUKCA_HERE, p, X, random);
    mukca_unknowns_set_geometry_prior(u, &p->m.recording);
    solve(p);
    out->exact_m = exact.after_m[MUKCA_HERE];
    out->distance_m =
        sqrt(fmax(all * all - out->exact_m * out->exact_m, 0)); /* independent errors */
    out->probability[MUKCA_HERE] = exact.probability[MUKCA_HERE];
    return done;
}

/* Mean errors in random postures within the limits of `range`, over arms from the posterior. */
static bool draw(mukca_tip_error *out, mukca_arm_posterior *p, const mukca_chain *range, int where)
{
    const int at = MUKCA_RIGID + p->m.linear.n_columns, w = at + 3, rows = 3 * PROBES,
              joints = p->chain.n_joints;
    double *X = MUKCA_TAKE(&p->pool, double, rows *w);
    double *q = MUKCA_TAKE(&p->pool, double, PROBES *joints);
    const mukca_tip_change_task *task = p->task;
    const mukca_offsets *const model[2] = {task->from, task->to};
    const int skip = task->base_frame ? MUKCA_PARAMETERS : 0; /* in their theta */
    mukca_geometry *geometry = MUKCA_TAKE(&p->pool, mukca_geometry, 2);
    mukca_random random = mukca_random_seeded(1);
    if (p->pool.failed) return false;
    for (int k = 0; k < 2; k++)
        mukca_geometry_set(&geometry[k], &p->chain, model[k] ? model[k]->theta + skip : NULL);
    for (int i = 0; i < PROBES; i++) mukca_posture_draw(q + i * joints, range, &random);
    if (!mukca_arm_posterior_probe(X, w, p, q, PROBES)) return false;
    for (int i = 0; i < PROBES; i++)
        for (int k = 0; k < 2; k++) {
            mukca_frame tip;
            mukca_offsets_tip(&tip, model[k], &p->chain, &geometry[k], q + i * joints);
            for (int a = 0; a < 3; a++) {
                double *to = X + (3 * i + a) * w + at;
                to[1 + k] = to[0] + tip.p[a];
            }
        }
    mukca_dense_project(X, rows, w, 0, MUKCA_RIGID);
    return summarise(out, where, p, X, &random) &&
           (where != MUKCA_HERE || split_distance(out, p, X, &random));
}

/* The chain with the joint ranges of the samples as limits; marks the joints at rest. */
static void find_ranges(mukca_tip_error *out, mukca_chain *here, const mukca_recording *r)
{
    for (int j = 0; j < here->n_joints; j++) {
        mukca_element *e = &here->element[here->joint_element[j]];
        double range[2];
        mukca_recording_range(range, r, r->data->q, here->n_joints, j);
        e->lower = range[0], e->upper = range[1];
        out->at_rest[j] = !(e->upper - e->lower >= MUKCA_LEAST_RANGE);
    }
}

/* List the effects that any arm may have and these n do not contain, with a third of their sizes:
 * smooth functions of the posture.  Returns their number. */
static int list_smooth(mukca_effect *list, const mukca_effect *known, int n,
                       const mukca_chain *chain)
{
    int count = 0;
    for (int k = 0; k < MUKCA_EFFECT_COUNT; k++) {
        const mukca_effect_ops *ops = mukca_effect_catalogue[k];
        const mukca_effect_sizes *sizes = ops->sizes ? ops->sizes : &mukca_sizes_angle;
        const int wave = MUKCA_TRAIT_PERIODIC | MUKCA_TRAIT_SMOOTH;
        if (!(ops->info.traits & MUKCA_TRAIT_FLEXIBLE || (ops->info.traits & wave) == wave) ||
            (ops->info.needs & MUKCA_NEEDS_MASSES && chain->n_masses == 0))
            continue;
        for (int j = 0; j < (mukca_effect_has_joint(k) ? chain->n_joints : 1); j++) {
            mukca_effect e = {.kind = (mukca_effect_kind)k, .joint = j, .placement = -1};
            const bool turns = chain->element[chain->joint_element[j]].type != MUKCA_PRISMATIC;
            if (!mukca_effect_has_joint(k)) e.joint = -1;
            if ((ops->info.traits & MUKCA_TRAIT_PERIODIC && !turns) ||
                n + count == MUKCA_MAX_EFFECTS ||
                mukca_effect_set_variant(&e, NULL, chain->n_joints))
                continue;
            for (int t = 0; t < e.terms; t++) e.coefficient[t] = sizes->sigma[sizes->usual - 1] / 3;
            bool there = false;
            for (int i = 0; i < n; i++) there |= mukca_effect_same(&e, &known[i]);
            if (!there) list[count++] = e;
        }
    }
    return count;
}

/* Errors by the posterior of the table's effects or, if the samples show others, by that of all. */
static mukca_status predict_all(mukca_tip_error *out, mukca_arm_posterior *p,
                                const mukca_chain *here, mukca_error *error)
{
    const mukca_tip_error facts = *out;
    mukca_effect smooth[MUKCA_MAX_EFFECTS];
    double evidence;
    const mukca_offsets *to = p->task->to;
    bool drawn = draw(out, p, here, MUKCA_HERE) && draw(out, p, &p->chain, MUKCA_ELSEWHERE);
    const int n = list_smooth(smooth, to->effects, to->n_effects, &p->chain);
    MUKCA_TRY(mukca_arm_posterior_extend(&evidence, p, smooth, n, error));
    const double own = out->exact_m;
    out->lacking_m = NAN;
    if (evidence > least_evidence) {
        *out = facts;
        drawn &= draw(out, p, here, MUKCA_HERE) && draw(out, p, &p->chain, MUKCA_ELSEWHERE);
        out->lacking_m = sqrt(fmax(out->exact_m * out->exact_m - own * own, 0));
    }
    return drawn ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "out of memory");
}

/* Count the postures that deviate and list their rows, with dots for those that do not fit.  The
 * targets of a row count once. */
static void list_outliers(mukca_tip_error *out, const mukca_arm_posterior *p)
{
    const mukca_dataset *d = &p->data;
    mukca_text rows = MUKCA_TEXT(out->rows);
    int last = -1;
    for (int row = 0; row < d->n_rows; row++) {
        const double size = mukca_norm3(p->residual[row]);
        char name[48] = "";
        out->gross += size > gross_error;
        out->worst_m = fmax(out->worst_m, size);
        if (!(size > outlier * p->m.unknowns.sigma) || d->row[row] == last) continue;
        last = d->row[row];
        if (d->n_files > 1)
            snprintf(name, sizeof name, "%.40s:", mukca_file_name(d->files[d->file[row]]));
        if (rows.used + strlen(name) + 18 <= rows.size)
            mukca_text_put(&rows, "%s%s%d", out->outliers ? ", " : "", name, last);
        else if (rows.at[rows.used - 1] != '.')
            mukca_text_put(&rows, ", ...");
        out->outliers++;
    }
}

/* Whether the residuals are those of a tip that turns about the axis of a joint whose angles do not
 * change. */
static bool turns_about(const mukca_arm_posterior *p, int joint)
{
    mukca_frame frame[MUKCA_MAX_ELEMENTS];
    double axis[3], across = 0, along = 0;
    const mukca_recording *r = &p->m.recording;
    const int k = p->chain.joint_element[joint];
    if (p->chain.element[k].type == MUKCA_PRISMATIC) return false;
    for (int i = 0; i < r->n_samples; i++) {
        const int row = r->order[i];
        const double *e = p->residual[row], w = p->weight[row] * p->weight[row];
        mukca_fk_frames(frame, NULL, &p->m.unknowns.arm.geometry,
                        p->data.q + row * p->data.n_joints, NULL);
        mukca_mat3_vec(axis, frame[k].R, p->chain.element[k].axis);
        const double part = mukca_dot3(axis, e);
        along += w * part * part;
        across += w * (mukca_dot3(e, e) - part * part) / 2;
    }
    return log(across / along) > 2 * sqrt(spread * spread + 3.0 / p->postures);
}

/* What the fit says of the samples. */
static void describe(mukca_tip_error *out, mukca_chain *here, const mukca_arm_posterior *p)
{
    *here = p->chain;
    find_ranges(out, here, &p->m.recording);
    out->postures = p->postures;
    list_outliers(out, p);
    const int tip = mukca_chain_tip_element(&p->chain);
    if (tip >= 0)
        out->tool_m =
            mukca_distance3(p->m.unknowns.arm.geometry.origin[tip].p, p->chain.element[tip].xyz);
    for (int j = 0; j < here->n_joints; j++) out->stuck[j] = out->at_rest[j] && turns_about(p, j);
}

mukca_status mukca_tip_error_expect(mukca_tip_error *out, const mukca_tip_change_task *task,
                                    mukca_error *error)
{
    mukca_pool pool = {0};
    mukca_arm_posterior *p = MUKCA_TAKE(&pool, mukca_arm_posterior, 1);
    mukca_chain *here = MUKCA_TAKE(&pool, mukca_chain, 1);
    *out = (mukca_tip_error){0};
    mukca_status status = pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory")
                                      : mukca_arm_posterior_fit(p, task, error);
    if (status == MUKCA_OK) {
        describe(out, here, p);
        status = predict_all(out, p, here, error);
    }
    if (p) mukca_arm_posterior_free(p);
    mukca_pool_free(&pool);
    return status;
}
