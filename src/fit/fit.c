/* A whole fit: free parameters, cost, solver, verdict, identifiability. */
#include "fit/fit.h"

#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "fit/align.h"
#include "model/dataset_subset.h"

/* ---- the user's lists of free and frozen parameters ---- */

enum { LONGEST = 512 }; /* item of a list */

static int find_parameter(const char *name)
{
    for (int i = 0; i < MUKCA_PARAMETERS; i++)
        if (!strcmp(mukca_parameter_name[i], name)) return i;
    return -1;
}

/* Mark the parameters of one item of a list. */
static mukca_status mark_item(unsigned char *mark, const mukca_chain *chain, const char *item,
                              unsigned char value, mukca_error *error)
{
    char joint[LONGEST];
    int element = mukca_chain_find_element(chain, item), parameter = -1;
    if (element < 0 && (parameter = find_parameter(item)) >= 0) {
        for (int k = 0; k < chain->n_elements; k++)
            if (mukca_parameters_standard(chain, k)) mark[MUKCA_PARAMETERS * k + parameter] = value;
        return MUKCA_OK;
    }
    const char *dot = strrchr(item, '.');
    if (element < 0 && dot && (parameter = find_parameter(dot + 1)) >= 0) {
        memcpy(joint, item, (size_t)(dot - item));
        joint[dot - item] = '\0';
        element = mukca_chain_find_element(chain, joint);
    }
    if (element < 0)
        return mukca_fail(
            error, MUKCA_USAGE,
            "parameter list: '%.64s' is neither a joint between %.64s and %.64s nor a parameter (x "
            "y z roll pitch yaw); write joint, parameter or joint.parameter",
            item, chain->base, chain->tip);
    for (int i = 0; i < MUKCA_PARAMETERS; i++)
        if (parameter < 0 || i == parameter) mark[MUKCA_PARAMETERS * element + i] = value;
    return MUKCA_OK;
}

static mukca_status mark_list(unsigned char *mark, const mukca_chain *chain, const char *list,
                              unsigned char value, mukca_error *error)
{
    char item[LONGEST];
    while (mukca_text_item(item, sizeof item, &list)) {
        if (!*item)
            return mukca_fail(error, MUKCA_USAGE,
                              "parameter list: an empty or overlong item; write "
                              "joint, parameter or joint.parameter, with commas");
        MUKCA_TRY(mark_item(mark, chain, item, value, error));
    }
    return MUKCA_OK;
}

mukca_status mukca_parameters_select(mukca_parameters *parameters, const mukca_chain *chain,
                                     const mukca_selection *selection, mukca_error *error)
{
    unsigned char mark[MUKCA_MAX_FREE] = {0};
    const char *list = selection->free;
    const bool adds = list && list[0] == '+';
    for (int k = 0; k < chain->n_elements; k++)
        if (mukca_parameters_standard(chain, k) &&
            (!list || adds || mukca_element_is_frame(&chain->element[k])))
            memset(mark + MUKCA_PARAMETERS * k, 1, MUKCA_PARAMETERS);
    if (list) MUKCA_TRY(mark_list(mark, chain, list + adds, 1, error));
    MUKCA_TRY(mark_list(mark, chain, selection->freeze, 0, error));
    mukca_parameters_set(parameters, chain, mark, selection->regularise_tip);
    if (parameters->n == 0)
        return mukca_fail(error, MUKCA_USAGE,
                          "no parameter is free: --freeze leaves nothing to fit");
    return MUKCA_OK;
}

/* ---- the fit ---- */

static mukca_status analyse(mukca_fit *fit, mukca_cost *cost, const double *x, mukca_pool *pool,
                            mukca_error *error)
{
    const int n = cost->n;
    double *H = cost->matrix[0], *g = cost->vector[0];
    const double value = mukca_cost_evaluate(&fit->calibrated, g, cost, x);
    mukca_cost_normal(H, cost, x, false);
    mukca_solver_factorise(H, n);
    fit->to_gain = mukca_solver_decrement(H, g, cost->vector[1], n) / (value > 0 ? value : 1);
    /* (1 nm)^2: rounding in a fit to data without noise */
    fit->converged = fit->to_gain * value <= 1e-9 * value + 1e-18;
    fit->n_measured = cost->observations.n_measured;
    return mukca_identify(&fit->identification, cost, x, pool, error);
}

/* Cost of all samples and, for a long recording, of the part from which the Hessian is computed. */
typedef struct {
    mukca_cost cost, part;
    mukca_dataset samples; /* of the part; empty if it is all */
    mukca_pool pool;
} workspace;

static mukca_status take_workspace(workspace *w, mukca_fit *fit, const mukca_dataset *data,
                                   mukca_cost_options options, mukca_error *error)
{
    options.theta = fit->theta;
    if (data->n_rows > MUKCA_MOST_SAMPLES) {
        MUKCA_TRY(mukca_part_take(&w->samples, data, MUKCA_MOST_SAMPLES, error));
        mukca_cost_setup(&w->part, &w->pool, &fit->chain, &fit->parameters, &w->samples, &options);
        options.part = &w->part;
        fit->n_part = w->samples.n_rows;
    }
    mukca_cost_setup(&w->cost, &w->pool, &fit->chain, &fit->parameters, data, &options);
    if (!w->pool.failed) return MUKCA_OK;
    return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows, %d parameters", data->n_rows,
                      fit->parameters.n);
}

static mukca_status minimise(mukca_fit *fit, workspace *w, const mukca_fit_options *options,
                             mukca_error *error)
{
    mukca_cost *cost = &w->cost;
    double nominal[MUKCA_MAX_FREE], x[MUKCA_MAX_FREE];
    const mukca_solver *solver = options->solver ? options->solver : &mukca_solver_gauss_newton;
    mukca_chain_theta(nominal, &fit->chain);
    mukca_parameters_pack(x, &fit->parameters, nominal);
    mukca_cost_evaluate(&fit->nominal, NULL, cost, x);
    mukca_parameters_pack(x, &fit->parameters, fit->theta);
    mukca_cost_hold(cost, x);
    if (options->start) mukca_parameters_pack(x, &fit->parameters, options->start);
    if (fit->n_part) { /* from the minimum of the part, few evaluations of all are left */
        mukca_cost_hold(&w->part, x);
        MUKCA_TRY(solver->run(x, &fit->outcome, &w->part, solver, &options->limits, error));
    }
    if (fit->outcome.stop != MUKCA_STOP_STOPPED)
        MUKCA_TRY(solver->run(x, &fit->outcome, cost, solver, &options->limits, error));
    if (fit->outcome.stop == MUKCA_STOP_STOPPED)
        return mukca_fail(error, MUKCA_INTERRUPTED, "interrupted; nothing was written");
    mukca_parameters_unpack(fit->theta, &fit->parameters, x);
    return options->parameters_only ? MUKCA_OK : analyse(fit, cost, x, &w->pool, error);
}

mukca_status mukca_fit_run(mukca_fit *fit, const mukca_chain *chain, const mukca_dataset *data,
                           const mukca_fit_options *options, mukca_error *error)
{
    memset(fit, 0, sizeof *fit);
    if (data->n_rows < 1) return mukca_fail(error, MUKCA_INPUT, "there are no rows to fit");
    MUKCA_TRY(
        mukca_chain_with_frames(&fit->chain, chain, options->free_base, options->free_tool, error));
    MUKCA_TRY(mukca_parameters_select(&fit->parameters, &fit->chain, &options->selection, error));
    MUKCA_TRY(mukca_frames_start(fit->theta, &fit->chain, data, options->free_base,
                                 options->free_tool, error));
    workspace *w = calloc(1, sizeof *w);
    if (!w) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_status status = take_workspace(w, fit, data, options->cost, error);
    if (status == MUKCA_OK) status = minimise(fit, w, options, error);
    mukca_pool_free(&w->pool);
    mukca_dataset_free(&w->samples);
    free(w);
    return status;
}
