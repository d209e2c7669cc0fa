/* Statistics and one-dimensional minimisation. */
#ifndef MUKCA_MATH_STATS_H
#define MUKCA_MATH_STATS_H

/* Mean length of a 3-vector of independent standard normals: 2 sqrt(2 / pi). */
#define MUKCA_MEAN_NORM3 1.5957691216057308

/* Half-width of a 95 % interval in sigmas: the 0.975 quantile of the normal distribution. */
#define MUKCA_SIGMAS_95 1.959963984540054

/* Degrees of freedom of Student's distribution for errors: finite variance and heavy tails. */
#define MUKCA_STUDENT_FREEDOM 4.0

void mukca_stats_sort(double *x, int n);                 /* ascending */
double mukca_stats_median(double *x, int n);             /* reorders x; 0 for n = 0 */
double mukca_stats_quantile(double *x, int n, double p); /* linear interpolation; reorders x */
double mukca_stats_log_sum_exp(const double *x, int n);  /* -HUGE_VAL for n = 0 */
double mukca_stats_log_normal_cdf(double z); /* log Phi(z), accurate far into the tail */

/* Minimise f over [lo, hi] by golden section with parabolic steps (Brent).  Returns the argument
 * within `tolerance`; *value (may be NULL) is f there. */
double mukca_stats_minimize(double *value, double (*f)(void *, double), void *context, double lo,
                            double hi, double tolerance);

#endif
