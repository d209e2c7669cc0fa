/* Contribution of heavy-tailed, correlated or single-joint noise to the score of a candidate.
 *
 * A badly seated ball remains badly seated for several samples, which Gaussian evidence mistakes
 * for a moved socket.  Therefore the residuals with and without the candidate are compared again,
 * by their likelihood as first-order autoregressive series with Gaussian or Student's t
 * innovations.
 *
 * Coarse steps of a recorded angle, or a brake that engages at varying angles, displace the ball
 * along the lever of one joint only.  Among hundreds of orders of ripple some fit such errors
 * better than isotropic noise would permit.  Therefore the residuals are also compared under noise
 * in the angle of one joint.
 */
#include "diagnose/heavy_tails.h"

#include <math.h>
#include <string.h>

#include "math/four.h"

/* Degrees of freedom recommended if unknown (Lange, Little and Taylor 1989). */
#define STUDENT_NU 4.0
#define PI 3.14159265358979323846
/* AR(1) coefficients of the noise: first those of the evidence, then up to the largest in
 * recordings. */
static const double memories[] = {0, 0.25, 0.5, 0.7, 0.85};
enum { USUAL_MEMORIES = 3, MEMORIES = sizeof memories / sizeof *memories };

/* Residuals r[n_samples][3] of the fitted model, m.  factor[n_stored]: scratch, factors of the
 * stored columns, 0 if not in use. */
MUKCA_CLONES static void residuals(double *r, double *factor, const mukca_regression *m)
{
    const mukca_linearisation *linear = &m->linear;
    const int n = linear->n_columns, stored = linear->n_stored, d = m->recording.dim;
    memset(factor, 0, sizeof *factor * (size_t)stored);
    for (int k = 0; k < n; k++) factor[linear->at[k]] = -m->evidence.mean[k];
    factor[linear->at[n]] = 1;
    for (int i = 0; i < m->recording.n_samples; i++)
        for (int c = 0; c < 3; c++)
            r[3 * i + c] = dot4(linear->columns + (size_t)(i * d + c) * (size_t)linear->stride,
                                factor, stored);
}

/* square[] := squared innovations of a first-order series about their mean in each socket, each
 * sample conditional on its predecessor; returns their number. */
static int innovations(double *square, const double *r, const mukca_recording *recording,
                       double memory)
{
    int count = 0;
    for (int g = 0; g < recording->n_groups; g++) {
        const mukca_group *group = &recording->groups[g];
        const double *x = r + (size_t)3 * (size_t)group->start;
        if (group->count < 2) continue;
        for (int i = 1; i < group->count; i++) square[count + i - 1] = 0;
        for (int c = 0; c < 3; c++) {
            double mean = 0;
            for (int i = 1; i < group->count; i++) mean += x[3 * i + c] - memory * x[3 * i - 3 + c];
            mean /= group->count - 1;
            for (int i = 1; i < group->count; i++) {
                const double e = x[3 * i + c] - memory * x[3 * i - 3 + c] - mean;
                square[count + i - 1] += e * e;
            }
        }
        count += group->count - 1;
    }
    return count;
}

/* Sum of x / (scale + x). */
MUKCA_CLONES static double sum_fractions(const double *x, int n, double scale)
{
    four s = {0};
    const int n4 = n & ~3;
    for (int i = 0; i < n4; i += 4) s += LOAD4(x + i) / (scale + LOAD4(x + i));
    double sum = (s[0] + s[1]) + (s[2] + s[3]);
    for (int i = n4; i < n; i++) sum += x[i] / (scale + x[i]);
    return sum;
}

/* Log likelihood of vectors with these squared lengths, maximised over the scale; nu: degrees of
 * freedom, infinite: Gaussian.  Constants are included, as the two are compared. */
static double likelihood(const double *square, int count, double nu)
{
    double variance = 1e-18, sum = 0, product = 1; /* one logarithm for several factors */
    for (int i = 0; i < count; i++) variance += square[i];
    variance /= 3 * count;
    if (!isfinite(nu)) return -1.5 * count * (log(2 * PI * variance) + 1);
    double before = 0;
    for (int pass = 0; pass < 30 && fabs(variance - before) > 1e-6 * variance; pass++) {
        before = variance; /* expectation maximisation */
        variance *= (nu + 3) * sum_fractions(square, count, nu * variance) / (3 * count);
        variance += 1e-18;
    }
    for (int i = 0; i < count; i++) {
        product *= 1 + square[i] / (variance * nu);
        if (product > 1e100 || i + 1 == count) sum -= log(product), product = 1;
    }
    return 0.5 * (nu + 3) * sum +
           count * (lgamma(0.5 * (nu + 3)) - lgamma(0.5 * nu) - 1.5 * log(nu * PI * variance));
}

/* value[0]: largest log likelihood under the noise of the evidence, value[1]: also with heavy tails
 * and long memory. */
static void explain(double value[2], double *square, const double *r,
                    const mukca_recording *recording)
{
    value[0] = value[1] = -HUGE_VAL;
    for (int i = 0; i < MEMORIES; i++) {
        const int count = innovations(square, r, recording, memories[i]);
        const double gaussian = likelihood(square, count, INFINITY);
        if (i < USUAL_MEMORIES) value[0] = fmax(value[0], gaussian);
        value[1] = fmax(value[1], fmax(gaussian, likelihood(square, count, STUDENT_NU)));
    }
}

/* Subtract the mean of each socket from r[n_samples][3]. */
static void centre(double *r, const mukca_recording *recording)
{
    for (int g = 0; g < recording->n_groups; g++) {
        const mukca_group *group = &recording->groups[g];
        double *x = r + (size_t)3 * (size_t)group->start, mean[3] = {0};
        for (int i = 0; i < 3 * group->count; i++) mean[i % 3] += x[i] / group->count;
        for (int i = 0; i < 3 * group->count; i++) x[i] -= mean[i % 3];
    }
}

/* Log likelihood of the centred residuals r with additional noise in a joint's angle: at the
 * joint's rms lever, `share` times the variance of the other noise. */
static double joint_likelihood(const double *r, const mukca_regression *m, int joint, double share)
{
    const mukca_recording *recording = &m->recording;
    const int n = recording->n_samples, step = recording->chain->n_joints * recording->dim;
    const double *lever = m->linear.lever + joint * recording->dim;
    double square = 1e-12, variance = 1e-18, log_ratios = 0; /* at least (1 um)^2 */
    for (int i = 0; i < n; i++) square += mukca_dot3(lever + i * step, lever + i * step) / n;
    for (int i = 0; i < n; i++) {
        const double *l = lever + i * step, *x = r + 3 * i, length = mukca_dot3(l, l),
                     ratio = 1 + share * length / square, along = mukca_dot3(l, x);
        variance += mukca_dot3(x, x) / (3 * n);
        if (length > 0) variance -= along * along / length * (1 - 1 / ratio) / (3 * n);
        log_ratios += log(ratio);
    }
    return -0.5 * (3 * n * log(variance) + log_ratios);
}

/* value[0]: log likelihood of the centred residuals under isotropic noise, value[1]: also with
 * additional noise in the angle of one joint. */
static void explain_joint(double value[2], const double *r, const mukca_regression *m)
{
    static const double shares[] = {0.25, 0.5, 1, 2, 4, 8, 16, 32, 64};
    value[0] = value[1] = joint_likelihood(r, m, 0, 0);
    for (int j = 0; j < m->recording.chain->n_joints; j++)
        for (size_t k = 0; k < sizeof shares / sizeof *shares; k++)
            value[1] = fmax(value[1], joint_likelihood(r, m, j, shares[k]));
}

/* Log likelihoods with the present causes, at the present noise and scales of the model: a
 * candidate is linear, and its likelihood hardly depends on them. */
static void explain_causes(double value[2], mukca_regression *m, double *scratch, bool of_joint)
{
    mukca_regression_solve(m);
    residuals(scratch, m->linear.change, m);
    if (!of_joint) {
        explain(value, scratch + 3 * (size_t)m->recording.data->n_rows, scratch, &m->recording);
        return;
    }
    centre(scratch, &m->recording);
    explain_joint(value, scratch, m);
}

double mukca_heavy_tails_gain(mukca_heavy_tails *tails, mukca_regression *m, int without,
                              const mukca_candidate *candidate)
{
    mukca_unknowns *u = &m->unknowns;
    const bool of_joint = mukca_effect_has(mukca_candidate_class(candidate), MUKCA_TRAIT_OWN_ANGLE);
    double value[2], gain = 0;
    mukca_unknowns_assign(&tails->kept, u);
    if (without >= 0) mukca_unknowns_drop(u, without);
    if (!tails->known) explain_causes(tails->value, m, tails->scratch, of_joint);
    tails->known = true;
    if (mukca_unknowns_add(u, candidate)) {
        explain_causes(value, m, tails->scratch, of_joint);
        gain = (value[0] - tails->value[0]) - (value[1] - tails->value[1]);
    }
    mukca_unknowns_assign(u, &tails->kept);
    mukca_regression_return(m);
    return fmax(gain, 0);
}

bool mukca_heavy_tails_create(mukca_heavy_tails *tails, mukca_pool *pool, const mukca_regression *m)
{
    *tails = (mukca_heavy_tails){
        .scratch = MUKCA_TAKE(pool, double, 4 * (size_t)m->recording.data->n_rows)};
    return mukca_unknowns_clone(&tails->kept, pool, &m->unknowns) && !pool->failed;
}
