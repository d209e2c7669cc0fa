/* Held-out error of a calibration. */
#include "fit/cross_validation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fit/frames.h"
#include "fit/part.h"
#include "model/dataset_subset.h"

enum {
    BLOCKS = 5,      /* of consecutive samples, which are correlated; as in diagnose */
    MOST_FOLDS = 10, /* more placements are merged */
    /* Beyond this number only a part of the samples is fitted and predicted: enough for the
     * parameters of any geometry, and its mean error is known to 1 %. */
    MOST_SAMPLES = 10000
};

/* fold[n_rows]: the placements; for a single placement and for measured poses, blocks of each
 * socket in recording order; -1: sample not used.  Returns the number of folds; keep[n_rows] is
 * scratch. */
static int assign(int *fold, bool *placements, const mukca_dataset *data, unsigned char *keep)
{
    int *count = calloc(2 * ((size_t)data->n_sockets + 1), sizeof *count), *seen;
    if (!count || mukca_part_mark(keep, data, MOST_SAMPLES) < 0) {
        free(count);
        return -1;
    }
    const int folds = data->n_placements < MOST_FOLDS ? data->n_placements : MOST_FOLDS;
    bool used[MOST_FOLDS + BLOCKS] = {false};
    int n = 0, index[MOST_FOLDS + BLOCKS];
    seen = count + data->n_sockets + 1;
    *placements = data->n_placements > 1;
    for (int i = 0; i < data->n_rows; i++) count[data->socket[i] + 1]++;
    for (int i = 0; i < data->n_rows; i++) {
        const int s = data->socket[i] + 1, before = seen[s]++;
        fold[i] = -1;
        if (!keep[i]) continue;
        if (s > 0 && *placements)
            fold[i] =
                (int)((long long)folds * mukca_dataset_placement(data, i) / data->n_placements);
        else
            fold[i] = MOST_FOLDS + (int)((long long)BLOCKS * before / count[s]);
        used[fold[i]] = true;
    }
    for (int f = 0; f < MOST_FOLDS + BLOCKS; f++) index[f] = used[f] ? n++ : -1;
    for (int i = 0; i < data->n_rows; i++)
        if (fold[i] >= 0) fold[i] = index[fold[i]];
    free(count);
    return n;
}

typedef struct {
    double nominal, mean;
    int rows;
} sums;

/* Add the errors of a model in the held-out samples. */
static mukca_status add_scores(double *sum, int *rows, const mukca_model *model,
                               const mukca_dataset *held, mukca_error *error)
{
    mukca_score *scores = calloc((size_t)held->n_placements + 1, sizeof *scores);
    const int n = scores ? mukca_evaluate(scores, NULL, model, held) : -1;
    *rows = 0;
    for (int i = 0; i < n; i++) {
        if (!isfinite(scores[i].mae)) continue;
        *sum += scores[i].rows * scores[i].mae;
        *rows += scores[i].rows;
    }
    free(scores);
    return n >= 0 ? MUKCA_OK : mukca_fail(error, MUKCA_MEMORY, "out of memory");
}

static mukca_status hold_out(sums *s, const mukca_chain *chain, const mukca_dataset *train,
                             const mukca_dataset *held, const mukca_fit_options *options,
                             mukca_error *error)
{
    mukca_fit fit = {0};
    double start[MUKCA_MAX_FREE];
    int rows = 0;
    mukca_status status = mukca_fit_run(&fit, chain, train, options, error);
    if (status != MUKCA_OK) return status;
    const mukca_model nominal = {.chain = &fit.chain, .theta = start},
                      fitted = {.chain = &fit.chain, .theta = fit.theta};
    status =
        mukca_frames_start(start, &fit.chain, train, options->free_base, options->free_tool, error);
    if (status == MUKCA_OK) status = add_scores(&s->nominal, &rows, &nominal, held, error);
    if (status == MUKCA_OK) status = add_scores(&s->mean, &rows, &fitted, held, error);
    s->rows += rows;
    mukca_fit_free(&fit);
    return status;
}

mukca_status mukca_fit_cross_validate(mukca_cross_validation *result, const mukca_chain *chain,
                                      const mukca_dataset *data, const mukca_fit_options *options,
                                      mukca_error *error)
{
    mukca_fit_options inner = *options;
    mukca_status status = MUKCA_OK;
    sums s = {0};
    const size_t room = (size_t)data->n_rows + 1;
    int *fold = malloc(room * sizeof *fold);
    unsigned char *keep = malloc(room);
    *result = (mukca_cross_validation){.nominal = NAN, .mean = NAN};
    const int folds = fold && keep ? assign(fold, &result->placements, data, keep) : -1;
    if (folds < 0) status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    inner.solver = NULL;
    inner.limits.progress = NULL;
    inner.parameters_only = true;
    for (int f = 0; f < folds && folds > 1 && status == MUKCA_OK; f++) {
        mukca_dataset part[2] = {{0}};
        for (int held = 0; held < 2 && status == MUKCA_OK; held++) {
            for (int i = 0; i < data->n_rows; i++)
                keep[i] = held ? fold[i] == f : fold[i] >= 0 && fold[i] != f;
            status = mukca_dataset_subset(&part[held], data, keep, error);
        }
        if (status == MUKCA_OK) status = hold_out(&s, chain, &part[0], &part[1], &inner, error);
        for (int held = 0; held < 2; held++) mukca_dataset_free(&part[held]);
    }
    if (s.rows > 0 && status == MUKCA_OK) {
        result->folds = folds;
        result->samples = data->n_rows > MOST_SAMPLES ? s.rows : 0;
        result->nominal = s.nominal / s.rows;
        result->mean = s.mean / s.rows;
    }
    free(fold);
    free(keep);
    return status;
}
