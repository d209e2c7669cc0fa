/* The last result and the table in use on the same samples. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose/condense.h"
#include "fit/accept.h"
#include "fit/evaluate.h"
#include "io/dataset_load.h"
#include "record/server.h"

/* error[n_rows]; false: out of memory. */
static bool find_errors(double *error, const mukca_chain *chain, const mukca_offsets *table,
                        const mukca_dataset *data)
{
    mukca_effect effects[MUKCA_MAX_EFFECTS];
    const mukca_model model = {
        .chain = chain, .theta = table->theta, .effects = effects, .n_effects = table->n_effects};
    mukca_offsets_place_effects(effects, table, data);
    return mukca_evaluate_rows(error, &model, data);
}

static mukca_status find_difference(mukca_difference *d, mukca_server *s, const mukca_dataset *data,
                                    mukca_error *error)
{
    const int n = data->n_rows;
    double *errors = calloc(2 * ((size_t)n + 1), sizeof *errors);
    const bool found = errors && find_errors(errors, s->recorder.chain, &s->pose.offsets, data) &&
                       find_errors(errors + n, s->recorder.chain, &s->candidate, data);
    const mukca_status status = found ? mukca_difference_find(d, errors, errors + n, data, error)
                                      : mukca_fail(error, MUKCA_MEMORY, "out of memory");
    free(errors);
    return status;
}

mukca_status mukca_server_compare(mukca_difference *d, mukca_server *s, const char *table,
                                  mukca_error *error)
{
    char name[MUKCA_NAME_SIZE + 16], path[MUKCA_SERVER_PATH];
    const char *paths[1] = {path};
    const mukca_dataset_options options = {.partial = true};
    mukca_dataset data = {0};
    mukca_condensed condensed;
    *d = (mukca_difference){0};
    snprintf(name, sizeof name, "%s", table);
    char *ending = strstr(name, ".offsets.tsv");
    if (!ending) ending = strstr(name, ".effects.tsv");
    if (ending) *ending = '\0';
    mukca_server_path(path, s, MUKCA_SERVER_SESSIONS, name, ".tsv");
    if (mukca_dataset_load(&data, s->recorder.chain, paths, 1, &options, error) != MUKCA_OK)
        return MUKCA_OK;
    mukca_status status = mukca_condense(&condensed, &data, MUKCA_MOST_SAMPLES, error);
    if (status == MUKCA_OK) status = find_difference(d, s, &data, error);
    if (!isfinite(d->sigma_m)) *d = (mukca_difference){0}; /* a single posture shows nothing */
    mukca_dataset_free(&data);
    return status;
}
