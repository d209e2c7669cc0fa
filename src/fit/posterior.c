/* Prior and posterior of the geometry; of an arm: unknowns, observations, memory. */
#include <math.h>
#include <string.h>

#include "fit/posterior.h"
#include "math/dense.h"
#include "model/dataset_subset.h"
#include "model/prior.h"

enum { MOST_ROWS = 5000 }; /* as in diagnose */

/* One observation for each posture of each group. */
static void list_observations(mukca_arm_posterior *p)
{
    const mukca_dataset *d = &p->data;
    int *posture = MUKCA_TAKE(&p->pool, int, d->n_rows),
        *last = MUKCA_TAKE(&p->pool, int, d->n_rows);
    p->of_row = MUKCA_TAKE(&p->pool, int, d->n_rows);
    p->list = MUKCA_TAKE(&p->pool, mukca_arm_observation, d->n_rows);
    if (p->pool.failed) return;
    p->postures = d->n_rows - mukca_postures_find(posture, &p->pool, d);
    for (int row = 0; row < d->n_rows; row++) {
        const int first = posture[row], target = mukca_dataset_target(d, row) + 1;
        const int group = d->socket[row] >= 0 ? d->socket[row]
                          : d->position && isfinite(d->position[3 * (size_t)row])
                              ? d->n_sockets + d->file[row] * (d->n_targets + 1) + target
                              : -1;
        int o = first == row ? -1 : last[first];
        if (first == row) last[row] = -1;
        p->of_row[row] = -1;
        if (group < 0) continue;
        while (o >= 0 && p->list[o].group != group) o = p->list[o].next;
        if (o < 0) {
            o = p->n_list++;
            p->list[o] = (mukca_arm_observation){.group = group, .next = last[first], .weight = 1};
            last[first] = o;
        }
        p->list[o].rows++;
        p->of_row[row] = o;
    }
}

/* Choose the unknowns, and take memory. */
static mukca_status set_up(mukca_arm_posterior *p, mukca_error *error)
{
    const mukca_tip_change_task *task = p->task;
    if (p->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_parameters_set(&p->parameters, &p->chain, NULL, false);
    const int last = p->chain.n_elements - 1;
    mukca_chain_theta(p->theta, &p->chain);
    for (int i = 0; i < MUKCA_PARAMETERS && task->tool_frame; i++)
        p->theta[MUKCA_PARAMETERS * last + i] = p->to[MUKCA_PARAMETERS * last + i];
    memcpy(p->nominal, p->theta, sizeof p->nominal);
    mukca_offsets_place_effects(p->effects, task->to, &p->data);
    for (int i = 0; i < p->parameters.n; i++)
        if (!task->tool_frame || p->parameters.index[i] / MUKCA_PARAMETERS != last)
            p->parameters.index[p->n_geometry++] = p->parameters.index[i];
    p->n = p->parameters.n = p->n_geometry;
    for (int e = 0; e < task->to->n_effects; e++) p->n += p->effects[e].terms;
    p->width = MUKCA_NUISANCE + p->n + 1;
    p->n_groups = p->data.n_sockets + p->data.n_files * (p->data.n_targets + 1);
    p->sigma = MUKCA_TAKE(&p->pool, double, p->n + 1);
    p->mean = MUKCA_TAKE(&p->pool, double, p->n + 1);
    p->step = MUKCA_TAKE(&p->pool, double, p->n + 1);
    p->L = MUKCA_TAKE(&p->pool, double, p->n * p->n + 1);
    p->inverse = MUKCA_TAKE(&p->pool, double, p->n * p->n + 1);
    p->gram = MUKCA_TAKE(&p->pool, double, p->width * p->width);
    p->reduced = MUKCA_TAKE(&p->pool, double, p->n_groups *MUKCA_NUISANCE * p->width);
    p->distance_weight = MUKCA_TAKE(&p->pool, double, p->data.n_distances + 1);
    p->group_weight = MUKCA_TAKE(&p->pool, double, p->n_groups + 1);
    for (int i = 0; i < p->n_list; i++) p->list[i].x = MUKCA_TAKE(&p->pool, double, 3 * p->width);
    if (p->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    mukca_posterior_prior(p->sigma, &p->chain, &p->parameters);
    for (int c = p->n_geometry; c < p->n; c++) { /* nearly flat: the evidence named the effect */
        double *value = mukca_arm_posterior_coefficient(p, c - p->n_geometry);
        p->sigma[c] = fmax(3 * fabs(*value), 1e-12);
        *value = 0;
    }
    return MUKCA_OK;
}

/* The chain without the frame of the measurement before it. */
static void remove_base(mukca_arm_posterior *p)
{
    const mukca_tip_change_task *task = p->task;
    p->chain = *task->chain;
    p->to = task->to->theta;
    if (!task->base_frame) return;
    mukca_chain_remove_first(&p->chain);
    p->to += MUKCA_PARAMETERS;
}

mukca_status mukca_arm_posterior_create(mukca_arm_posterior *p, const mukca_tip_change_task *task,
                                        mukca_error *error)
{
    memset(p, 0, sizeof *p);
    p->task = task;
    p->noise = MUKCA_PRIOR_NOISE;
    p->scale = 1;
    p->tracker = (mukca_frame){.R = MUKCA_IDENTITY};
    remove_base(p);
    mukca_status status = mukca_part_take(&p->data, task->data, MOST_ROWS, error);
    if (status != MUKCA_OK) return status;
    list_observations(p);
    for (int i = 0; i < p->n_list; i++) p->poses |= p->list[i].group >= p->data.n_sockets;
    p->base = task->base_frame || task->free_base || !p->poses;
    p->tool = task->tool_frame || p->data.n_targets > 0;
    return set_up(p, error);
}

void mukca_arm_posterior_free(mukca_arm_posterior *p)
{
    mukca_dataset_free(&p->data);
    mukca_pool_free(&p->pool);
}

/* ---- prior of the geometry, posterior of parameters ---- */

void mukca_posterior_prior(double *sigma, const mukca_chain *chain,
                           const mukca_parameters *parameters)
{
    const int tool = mukca_chain_tip_element(chain);
    for (int i = 0; i < parameters->n; i++)
        sigma[i] = mukca_prior_sigma(&mukca_prior_expected, parameters->index[i] % MUKCA_PARAMETERS,
                                     parameters->index[i] / MUKCA_PARAMETERS == tool);
}

void mukca_posterior_factor(double *L, const double *gram, const double *sigma, double noise, int n)
{
    for (int i = 0; i < n * n; i++) L[i] = gram[i] / (noise * noise);
    for (int i = 0; i < n; i++) L[i * n + i] += 1 / (sigma[i] * sigma[i]);
    mukca_dense_cholesky(L, n); /* positive definite: every parameter has a prior */
}

void mukca_arm_point_init(mukca_arm_point *at, const mukca_chain *chain, const double *theta)
{
    memset(at, 0, sizeof *at);
    at->chain = chain;
    mukca_parameters_set(&at->parameters, chain, NULL, false);
    mukca_chain_theta(at->theta, chain);
    mukca_arm_point_move(at, theta ? theta : at->theta);
}

void mukca_arm_point_move(mukca_arm_point *at, const double *theta)
{
    memmove(at->theta, theta,
            (size_t)(MUKCA_PARAMETERS * at->chain->n_elements) * sizeof *at->theta);
    mukca_geometry_set(&at->geometry, at->chain, at->theta);
}

void mukca_arm_point_tip(double *J, int ld, double position[3], const mukca_arm_point *at,
                         const double *q)
{
    double all[3 * MUKCA_MAX_FREE];
    const int width = MUKCA_PARAMETERS * at->chain->n_elements;
    mukca_fk_parameter_jacobian(all, position, &at->geometry, at->theta, q);
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < at->parameters.n; c++)
            J[i * ld + c] = all[i * width + at->parameters.index[c]];
}
