/* Pairs of socket labels that were recorded in one socket. */
#include "fit/coincide.h"

#include <math.h>
#include <stdlib.h>

/* Samples whose predictions differ by less than the repeatability of a printed socket (0.1 to 0.2
 * mm) are of one posture and carry no information on sockets, m. */
static const double least_rms = 5e-5;

/* The predictions of a socket: their mean and sum of squares about it. */
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
    if (!clouds) return -1;
    mukca_geometry_set(&geometry, chain, theta);
    for (int i = 0; i < data->n_rows; i++) {
        double tip[3];
        if (data->socket[i] < 0) continue;
        cloud *c = &clouds[data->socket[i]];
        mukca_fk_position(tip, &geometry, data->q + (size_t)i * (size_t)data->n_joints, NULL);
        c->count++;
        for (int a = 0; a < 3; a++) { /* Welford 1962 */
            const double off = tip[a] - c->mean[a];
            c->mean[a] += off / c->count;
            c->squares += off * (tip[a] - c->mean[a]);
        }
    }
    for (int k = 0; k < data->n_distances; k++) {
        const mukca_distance *d = &data->distances[k];
        if (coincide(&apart[k], &clouds[d->a], &clouds[d->b], d->distance))
            found++;
        else
            apart[k] = (double)NAN;
    }
    free(clouds);
    return found;
}
