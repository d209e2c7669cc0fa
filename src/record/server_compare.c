/* The last result and the table in use on the same samples. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose/condense.h"
#include "fit/evaluate.h"
#include "io/dataset_load.h"
#include "record/server.h"

/* Distances of the samples from the mean of their socket, error[n_rows]; false: out of memory. */
static bool find_errors(double *error, const mukca_chain *chain, const mukca_offsets *table,
                        const mukca_dataset *data)
{
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    const mukca_model model = {
        .chain = chain, .theta = table->theta, .effects = effects, .n_effects = table->n_effects};
    mukca_frame *tips = malloc(((size_t)data->n_rows + 1) * sizeof *tips);
    double(*sum)[4] = calloc((size_t)data->n_sockets + 1, sizeof *sum);
    if (tips && sum) {
        mukca_offsets_place_effects(effects, table, data);
        mukca_evaluate_tips(tips, &model, data);
        for (int i = 0; i < data->n_rows; i++) {
            double *s = sum[data->socket[i] + 1]; /* the first: poses without a socket */
            for (int a = 0; a < 3; a++) s[a] += tips[i].p[a];
            s[3]++;
        }
        for (int i = 0; i < data->n_rows; i++) {
            const double *s = sum[data->socket[i] + 1];
            const double mean[3] = {s[0] / s[3], s[1] / s[3], s[2] / s[3]};
            error[i] = mukca_distance3(tips[i].p, mean);
        }
    }
    const bool ok = tips && sum;
    free(tips);
    free(sum);
    return ok;
}

static mukca_status find_difference(mukca_server_difference *d, mukca_server *s,
                                    const mukca_dataset *data, mukca_error *error)
{
    const int n = data->n_rows;
    double *errors = calloc(2 * ((size_t)n + 1), sizeof *errors), squares = 0;
    if (!errors || !find_errors(errors, s->recorder.chain, &s->pose.offsets, data) ||
        !find_errors(errors + n, s->recorder.chain, &s->candidate, data)) {
        free(errors);
        return mukca_fail(error, MUKCA_MEMORY, "out of memory");
    }
    for (int i = 0; i < n; i++) d->mean += (errors[n + i] - errors[i]) / n;
    for (int i = 0; i < n; i++) squares += pow(errors[n + i] - errors[i] - d->mean, 2);
    d->sigma = n > 1 ? sqrt(squares / n / (n - 1)) : HUGE_VAL;
    d->postures = n;
    free(errors);
    return MUKCA_OK;
}

mukca_status mukca_server_compare(mukca_server_difference *d, mukca_server *s, const char *table,
                                  mukca_error *error)
{
    char name[MUKCA_NAME_SIZE + 16], path[MUKCA_SERVER_PATH];
    const char *paths[1] = {path};
    const mukca_dataset_options options = {.partial = true};
    mukca_dataset data = {0};
    mukca_condensed condensed;
    *d = (mukca_server_difference){0};
    snprintf(name, sizeof name, "%s", table);
    char *ending = strstr(name, ".offsets.tsv");
    if (!ending) ending = strstr(name, ".effects.tsv");
    if (ending) *ending = '\0';
    mukca_server_path(path, s, MUKCA_SERVER_SESSIONS, name, ".tsv");
    if (mukca_dataset_load(&data, s->recorder.chain, paths, 1, &options, error) != MUKCA_OK)
        return MUKCA_OK;
    mukca_status status = mukca_condense(&condensed, &data, MUKCA_MOST_SAMPLES, error);
    if (status == MUKCA_OK) status = find_difference(d, s, &data, error);
    mukca_dataset_free(&data);
    return status;
}
