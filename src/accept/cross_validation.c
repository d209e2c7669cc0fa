/* Held-out error of a calibration. */
#include "accept/accept.h"

#include <math.h>

#include "fit/align.h"
#include "model/dataset_subset.h"

enum {
    SOCKET_BLOCKS = 5, /* errors are about the mean of a block, and vanish with its size */
    MOST_FOLDS = 10    /* more placements are merged */
};

/* fold[n_rows]: the placements; for a single placement and for measured poses, blocks of each
 * socket in recording order, with the readings of a posture in one block.  Returns the number of
 * folds; check the pool. */
static int assign(int *fold, bool *placements, mukca_pool *pool, const mukca_dataset *data)
{
    int *count = MUKCA_TAKE(pool, int, data->n_sockets + 1);
    int *seen = MUKCA_TAKE(pool, int, data->n_sockets + 1);
    int *posture = MUKCA_TAKE(pool, int, data->n_rows);
    if (!pool->failed) mukca_postures_find(posture, pool, data);
    if (pool->failed) return 0;
    const int folds = data->n_placements < MOST_FOLDS ? data->n_placements : MOST_FOLDS;
    bool used[MOST_FOLDS + MUKCA_POSE_FOLDS] = {false};
    int n = 0, index[MOST_FOLDS + MUKCA_POSE_FOLDS];
    *placements = data->n_placements > 1;
    for (int i = 0; i < data->n_rows; i++) count[data->socket[i] + 1]++;
    for (int i = 0; i < data->n_rows; i++) {
        const int s = data->socket[i] + 1, before = seen[s]++, first = posture[i];
        if (s > 0 && *placements)
            fold[i] =
                (int)((long long)folds * mukca_dataset_placement(data, i) / data->n_placements);
        else if (first < i && data->socket[first] + 1 == s)
            fold[i] = fold[first];
        else
            fold[i] = MOST_FOLDS + (int)((long long)(s > 0 ? SOCKET_BLOCKS : MUKCA_POSE_FOLDS) *
                                         before / count[s]);
        used[fold[i]] = true;
    }
    for (int f = 0; f < MOST_FOLDS + MUKCA_POSE_FOLDS; f++) index[f] = used[f] ? n++ : -1;
    for (int i = 0; i < data->n_rows; i++) fold[i] = index[fold[i]];
    return n;
}

/* Errors of the held-out samples by the nominal model, with the frames aligned to `train`, and by
 * the fit. */
static mukca_status predict(double *const errors[2], const mukca_fit *fit,
                            const mukca_dataset *train, const mukca_dataset *held,
                            const mukca_fit_options *options, mukca_error *error)
{
    double start[MUKCA_MAX_FREE];
    const mukca_model nominal = {.chain = &fit->chain, .theta = start},
                      fitted = {.chain = &fit->chain, .theta = fit->theta};
    const mukca_status status = mukca_frames_start(start, &fit->chain, train, options->free_base,
                                                   options->free_tool, error);
    if (status == MUKCA_OK && (!mukca_evaluate_rows(errors[0], &nominal, held) ||
                               !mukca_evaluate_rows(errors[1], &fitted, held)))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    return status;
}

/* Predict fold f from the others: its entries of before[n_rows] and after[n_rows]. */
static mukca_status predict_fold(mukca_cross_validation *r, const int *fold, int f,
                                 const mukca_chain *chain, const mukca_fit_options *options,
                                 mukca_error *error)
{
    const int rows = r->data.n_rows;
    mukca_pool pool = {0};
    unsigned char *keep = MUKCA_TAKE(&pool, unsigned char, rows);
    double *const errors[2] = {MUKCA_TAKE(&pool, double, rows), MUKCA_TAKE(&pool, double, rows)};
    mukca_dataset part[2] = {{0}};
    mukca_fit *fit = MUKCA_TAKE(&pool, mukca_fit, 1);
    mukca_status status = pool.failed ? mukca_fail(error, MUKCA_MEMORY, "out of memory") : MUKCA_OK;
    for (int held = 0; held < 2 && status == MUKCA_OK; held++) {
        for (int i = 0; i < rows; i++) keep[i] = (fold[i] == f) == held;
        status = mukca_dataset_subset(&part[held], &r->data, keep, error);
    }
    if (status == MUKCA_OK) status = mukca_fit_run(fit, chain, &part[0], options, error);
    if (status == MUKCA_OK) status = predict(errors, fit, &part[0], &part[1], options, error);
    for (int i = 0, k = 0; i < rows && status == MUKCA_OK; i++) {
        if (fold[i] != f) continue;
        r->before[i] = errors[0][k];
        r->after[i] = errors[1][k++];
    }
    for (int held = 0; held < 2; held++) mukca_dataset_free(&part[held]);
    mukca_pool_free(&pool);
    return status;
}

/* Predict each fold of r->data from the others. */
static mukca_status predict_folds(mukca_cross_validation *r, const mukca_chain *chain,
                                  const mukca_fit_options *options, mukca_error *error)
{
    int *fold = MUKCA_TAKE(&r->pool, int, r->data.n_rows);
    const int n = assign(fold, &r->placements, &r->pool, &r->data);
    mukca_status status = MUKCA_OK;
    if (r->pool.failed) return mukca_fail(error, MUKCA_MEMORY, "out of memory for the folds");
    r->folds = n > 1 ? n : 0;
    for (int i = 0; i < r->data.n_rows; i++) r->before[i] = r->after[i] = NAN;
    for (int f = 0; f < r->folds && status == MUKCA_OK; f++)
        status = predict_fold(r, fold, f, chain, options, error);
    return status;
}

void mukca_cross_validation_free(mukca_cross_validation *r)
{
    mukca_dataset_free(&r->data);
    mukca_pool_free(&r->pool);
}

mukca_status mukca_fit_cross_validate(mukca_cross_validation *r, const mukca_fit *fit,
                                      const mukca_chain *chain, const mukca_dataset *data,
                                      const mukca_fit_options *options, mukca_error *error)
{
    const bool tested = r->held && r->held->n_rows > 0;
    mukca_status status = MUKCA_OK;
    mukca_fit_options inner = *options;
    inner.start = fit->theta;
    inner.solver = NULL;
    inner.parameters_only = true;
    *r = (mukca_cross_validation){.held = tested ? r->held : &r->data};
    if (!tested) MUKCA_TRY(mukca_part_take(&r->data, data, MUKCA_MOST_SAMPLES, error));
    r->before = MUKCA_TAKE(&r->pool, double, r->held->n_rows);
    r->after = MUKCA_TAKE(&r->pool, double, r->held->n_rows);
    if (r->pool.failed)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    else if (tested)
        status =
            predict((double *const[]){r->before, r->after}, fit, data, r->held, options, error);
    else
        status = predict_folds(r, chain, &inner, error);
    if (status != MUKCA_OK) mukca_cross_validation_free(r);
    return status;
}
