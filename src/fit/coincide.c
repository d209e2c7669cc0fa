/* Pairs of socket labels that were recorded in one socket. */
#include "fit/coincide.h"

#include <math.h>
#include <stdlib.h>

/* Samples whose predictions differ by less than the repeatability of a printed socket (0.1 to 0.2
 * mm) are of one posture and carry no information on sockets, m. */
static const double least_rms = 5e-5;

/* The predictions of a socket: sums first, then the mean and the sum of squares about it. */
typedef struct {
    int count;
    double mean[3], squares;
} cloud;

static bool coincide(double *apart, const cloud *a, const cloud *b, double distance)
{
    if (!a->count || !b->count) return false;
    const double rms = sqrt((a->squares + b->squares) / (a->count + b->count));
    *apart = mukca_distance3(a->mean, b->mean);
    return *apart < fmax(rms, 0.08 * distance) && rms > least_rms && rms < 0.25 * distance;
}

int mukca_coincide_find(double *apart, const mukca_chain *chain, const double *theta,
                        const mukca_dataset *data)
{
    int found = 0;
    mukca_geometry geometry;
    cloud *clouds = calloc((size_t)data->n_sockets + 1, sizeof *clouds);
    double(*tip)[3] = malloc(((size_t)data->n_rows + 1) * sizeof *tip);
    if (!clouds || !tip) {
        free(clouds);
        free(tip);
        return -1;
    }
    mukca_geometry_set(&geometry, chain, theta);
    mukca_fk_positions(tip[0], &geometry, data->q, data->n_rows);
    for (int i = 0; i < data->n_rows; i++) {
        if (data->socket[i] < 0) continue;
        cloud *c = &clouds[data->socket[i]];
        c->count++;
        for (int a = 0; a < 3; a++) c->mean[a] += tip[i][a];
    }
    for (int s = 0; s < data->n_sockets; s++)
        for (int a = 0; a < 3 && clouds[s].count; a++) clouds[s].mean[a] /= clouds[s].count;
    for (int i = 0; i < data->n_rows; i++) {
        if (data->socket[i] < 0) continue;
        cloud *c = &clouds[data->socket[i]];
        const double off = mukca_distance3(tip[i], c->mean);
        c->squares += off * off;
    }
    for (int k = 0; k < data->n_distances; k++) {
        const mukca_distance *d = &data->distances[k];
        if (coincide(&apart[k], &clouds[d->a], &clouds[d->b], d->distance))
            found++;
        else
            apart[k] = (double)NAN;
    }
    free(clouds);
    free(tip);
    return found;
}
