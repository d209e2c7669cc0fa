/* The heart of mukca: the calibration of the paper (arXiv 2503.12584) and nothing else.
 *
 * usage: heart slsqp|lbfgs ARM FOLDER... >offsets.tsv
 */
#include <stdio.h>
#include <string.h>

#include "arm/offset_lines.h"
#include "fit/cost.h"
#include "fit/nlopt_adapter.h"
#include "heart/read.h"
#include "math/sincos.h"
#include "model/turn.h"

/* Of libm; the full program has a kernel for several angles at a time. */
void mukca_sincos(double *s, double *c, const double *x, int n)
{
    for (int i = 0; i < n; i++) s[i] = sin(x[i]), c[i] = cos(x[i]);
}

/* x = nominal + scale y, and J in units of the nominal model's: both of order one. */
typedef struct {
    mukca_cost cost;
    double unit, scale;
} fit;

static double objective(void *context, double *gradient, const double *y, bool *halt)
{
    fit *f = context;
    double x[MUKCA_MAX_FREE];
    for (int i = 0; i < f->cost.n; i++) x[i] = f->cost.nominal[i] + f->scale * y[i];
    const double value = mukca_cost_evaluate(NULL, gradient, &f->cost, x);
    for (int i = 0; i < f->cost.n && gradient; i++) gradient[i] *= f->scale / f->unit;
    *halt = !isfinite(value); /* NLopt does not stop at NaN */
    return value / f->unit;
}

/* Mean distance of a sample's tip from the mean of its socket, m, at x[n]. */
static double mean_error(mukca_cost *cost, const mukca_chain *chain, const mukca_dataset *data,
                         const double *x)
{
    mukca_geometry geometry;
    double sum = 0, tip[3];
    mukca_cost_evaluate(NULL, NULL, cost, x); /* predicts the means */
    mukca_geometry_set(&geometry, chain, cost->theta);
    for (int i = 0; i < data->n_rows; i++) {
        mukca_fk_tip(tip, &geometry, data->q + i * data->n_joints);
        sum += mukca_distance3(tip, cost->observations.mean + 3 * data->socket[i]);
    }
    return sum / data->n_rows;
}

static void write_table(const mukca_chain *chain, const mukca_cost *cost)
{
    puts("# offsets table of mukca's heart");
    mukca_offset_lines_names(stdout, chain);
    mukca_offset_lines_chain(stdout, chain);
    mukca_offset_lines_columns(stdout);
    for (int i = 0; i < cost->n; i++) {
        const int k = cost->parameters->index[i];
        const mukca_offset_row row = mukca_offset_row_parameter(chain, k, cost->theta[k]);
        mukca_offset_lines_row(stdout, &row);
    }
}

static mukca_status calibrate(fit *f, const mukca_chain *chain, const mukca_dataset *data,
                              mukca_nlopt_method method, mukca_error *error)
{
    const mukca_nlopt_problem problem = {objective, f, f->cost.n, 2000, 60};
    mukca_stop stop;
    mukca_cost_value J;
    double x[MUKCA_MAX_FREE] = {0};
    f->unit = mukca_cost_evaluate(NULL, NULL, &f->cost, f->cost.nominal);
    f->scale = sqrt(f->unit / 2);
    MUKCA_TRY(mukca_nlopt_minimise(x, &stop, &problem, method, error));
    for (int i = 0; i < f->cost.n; i++) x[i] = f->cost.nominal[i] + f->scale * x[i];
    const double nominal = mean_error(&f->cost, chain, data, f->cost.nominal);
    const double calibrated = mean_error(&f->cost, chain, data, x);
    mukca_cost_evaluate(&J, NULL, &f->cost, x);
    fprintf(stderr, "J %.12e m^2, mean error %.3e m, nominal %.3e m, %d evaluations\n", J.total,
            calibrated, nominal, f->cost.evaluations);
    write_table(chain, &f->cost);
    if (stop != MUKCA_STOP_TOLERANCE && stop != MUKCA_STOP_FAILED) /* LBFGS: no lower point */
        return mukca_fail(error, MUKCA_NEGATIVE, "the solver did not converge");
    return fflush(stdout) == 0 ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "cannot write");
}

int main(int argc, char **argv)
{
    static mukca_chain chain;
    static fit f;
    mukca_parameters parameters;
    mukca_dataset data = {0};
    mukca_pool pool = {0};
    mukca_error error = {.text = "usage: heart slsqp|lbfgs ARM FOLDER... >offsets.tsv"};
    const bool lbfgs = argc > 3 && strcmp(argv[1], "lbfgs") == 0;
    mukca_status status = MUKCA_USAGE;
    if (lbfgs || (argc > 3 && strcmp(argv[1], "slsqp") == 0))
        status = mukca_heart_arm(&chain, argv[2], &error);
    if (status == MUKCA_OK) status = mukca_heart_data(&data, &chain, argv + 3, argc - 3, &error);
    if (status == MUKCA_OK) {
        mukca_parameters_set(&parameters, &chain, NULL, false);
        status =
            mukca_cost_init(&f.cost, &pool, &chain, &parameters, &data, &(mukca_cost_options){0})
                ? calibrate(&f, &chain, &data, lbfgs ? MUKCA_NLOPT_LBFGS : MUKCA_NLOPT_SLSQP,
                            &error)
                : mukca_fail(&error, MUKCA_MEMORY, "out of memory");
    }
    if (status != MUKCA_OK) fprintf(stderr, "heart: %s\n", error.text);
    mukca_dataset_free(&data);
    mukca_pool_free(&pool);
    return (int)status;
}
