/* Postures: rows of a recording with the same joint angles; random ones. */
#include "model/dataset_subset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "math/stats.h"

/* Distances between readings of one posture and between postures, rad (m of a sliding joint):
 * encoder noise and servo steps are below the one, chosen postures above the other.  Between them
 * the widest gap in the data decides: a ball that is put back into its socket follows what drifted
 * since the last round, 10 mrad for 5 mm at half a metre. */
#define NEAR 0.2e-3
#define FAR 50e-3

enum { SAMPLED = 2000 }; /* rows in which the gap is searched: time linear in all rows */

typedef struct {
    double q;
    int row;
} sorted;

static int by_angle(const void *a, const void *b)
{
    const sorted *x = a, *y = b;
    return x->q != y->q ? (x->q > y->q) - (x->q < y->q) : x->row - y->row;
}

/* Largest difference of a joint's angles, or any from `limit` on; rows with another payload are
 * another posture. */
static double distance(const mukca_dataset *d, int a, int b, double limit)
{
    const double *p = d->q + (size_t)a * (size_t)d->n_joints,
                 *q = d->q + (size_t)b * (size_t)d->n_joints;
    double most = 0;
    for (int j = 0; j < d->n_joints && most < limit; j++) {
        const double off = fabs(p[j] - q[j]);
        if (off > most) most = off;
    }
    if (d->payload && d->payload[a] != d->payload[b] &&
        !(isnan(d->payload[a]) && isnan(d->payload[b])))
        return HUGE_VAL;
    return most;
}

/* Rows by the joint with the widest range, so that near rows are neighbours. */
static void sort_rows(sorted *order, const mukca_dataset *d)
{
    double widest = -1;
    int joint = 0;
    for (int j = 0; j < d->n_joints; j++) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (int row = 0; row < d->n_rows; row++) {
            low = fmin(low, d->q[row * d->n_joints + j]);
            high = fmax(high, d->q[row * d->n_joints + j]);
        }
        if (high - low > widest) widest = high - low, joint = j;
    }
    for (int row = 0; row < d->n_rows; row++)
        order[row] = (sorted){d->q[row * d->n_joints + joint], row};
    qsort(order, (size_t)d->n_rows, sizeof *order, by_angle);
}

/* Largest distance of readings of one posture: the middle, in logarithms, of the widest gap in the
 * distances of some rows to the nearest other one. */
static double find_tolerance(double *nearest, const sorted *order, const mukca_dataset *d)
{
    const int step = 1 + d->n_rows / SAMPLED;
    int n = 0;
    for (int i = 0; i < d->n_rows; i += step) {
        double least = FAR;
        for (int side = -1; side <= 1; side += 2)
            for (int k = i + side; k >= 0 && k < d->n_rows && fabs(order[k].q - order[i].q) < least;
                 k += side)
                least = fmin(least, distance(d, order[i].row, order[k].row, least));
        if (least > NEAR && least < FAR) nearest[n++] = least;
    }
    mukca_stats_sort(nearest, n);
    double widest = 0, tolerance = sqrt(NEAR * FAR);
    for (int i = 0; i <= n; i++) {
        const double low = i ? nearest[i - 1] : NEAR, high = i < n ? nearest[i] : FAR;
        if (high > widest * low) widest = high / low, tolerance = sqrt(high * low);
    }
    return tolerance;
}

int mukca_postures_find(int *posture, mukca_pool *pool, const mukca_dataset *d)
{
    const int rows = d->n_rows;
    sorted *order = MUKCA_TAKE(pool, sorted, rows);
    double *nearest = MUKCA_TAKE(pool, double, rows + 1);
    int *place = MUKCA_TAKE(pool, int, rows), repeats = 0;
    if (pool->failed) return 0;
    sort_rows(order, d);
    const double tolerance = find_tolerance(nearest, order, d);
    for (int i = 0; i < rows; i++) place[order[i].row] = i, posture[i] = -1;
    for (int row = 0; row < rows; row++) {
        double least = tolerance;
        int first = row;
        for (int side = -1; side <= 1; side += 2)
            for (int k = place[row] + side;
                 k >= 0 && k < rows && fabs(order[k].q - order[place[row]].q) < least; k += side) {
                const int other = order[k].row;
                if (other > row || posture[other] != other) continue;
                const double far = distance(d, row, other, least);
                if (far < least) least = far, first = other;
            }
        posture[row] = first;
        repeats += first != row;
    }
    return repeats;
}

void mukca_postures_move(double *move, int *repeat, mukca_pool *pool, const int *posture,
                         const mukca_dataset *d, const double *q)
{
    const int rows = d->n_rows, n = d->n_joints;
    double *mean = MUKCA_TAKE(pool, double, (size_t)rows *(size_t)n);
    int *count = MUKCA_TAKE(pool, int, rows);
    if (pool->failed) return;
    for (int row = 0; row < rows; row++, count[posture[row - 1]]++)
        for (int j = 0; j < n; j++) {
            double *of = &mean[posture[row] * n + j];
            *of += (q[row * n + j] - *of) / (count[posture[row]] + 1);
        }
    for (int row = 0; row < rows; row++) {
        const bool start = row == 0 || d->file[row] != d->file[row - 1];
        repeat[row] = start || posture[row] != posture[row - 1] ? 0 : repeat[row - 1] + 1;
        for (int j = 0; j < n; j++) {
            double *to = &move[row * n + j];
            if (start)
                *to = 0;
            else if (repeat[row])
                *to = to[-n];
            else
                *to = mean[posture[row] * n + j] - mean[posture[row - 1] * n + j];
        }
    }
}

void mukca_posture_draw(double *q, const mukca_chain *chain, mukca_random *random)
{
    for (int j = 0; j < chain->n_joints; j++) {
        const mukca_element *e = &chain->element[chain->joint_element[j]];
        const double half = e->type == MUKCA_PRISMATIC ? 0.5 : M_PI;
        const double lower = isfinite(e->lower) ? e->lower : -half;
        const double upper = isfinite(e->upper) ? e->upper : half;
        q[j] = lower + (upper - lower) * mukca_random_uniform(random);
    }
}

int mukca_dataset_find_socket(const mukca_dataset *d, const char *placement, const char *label)
{
    for (int s = d->n_sockets - 1; s >= 0; s--)
        if (strcmp(d->sockets[s].label, label) == 0 &&
            strcmp(d->placements[d->sockets[s].placement].name, placement) == 0)
            return s;
    return -1;
}

static bool same_labels(const mukca_socket *sockets, const mukca_distance *a,
                        const mukca_distance *b)
{
    return (strcmp(sockets[a->a].label, sockets[b->a].label) == 0 &&
            strcmp(sockets[a->b].label, sockets[b->b].label) == 0) ||
           (strcmp(sockets[a->a].label, sockets[b->b].label) == 0 &&
            strcmp(sockets[a->b].label, sockets[b->a].label) == 0);
}

int mukca_dataset_artefacts(const mukca_dataset *d)
{
    int n = 0;
    for (int k = 0; k < d->n_distances; k++)
        if (d->distances[k].artefact >= n) n = d->distances[k].artefact + 1;
    return n;
}

void mukca_dataset_number_distance(mukca_dataset *d)
{
    mukca_distance *last = &d->distances[--d->n_distances];
    last->artefact = mukca_dataset_artefacts(d);
    for (int k = 0; k < d->n_distances; k++)
        if (same_labels(d->sockets, &d->distances[k], last))
            last->artefact = d->distances[k].artefact;
    d->n_distances++;
}

int mukca_socket_mean(double mean[3], const mukca_geometry *geometry, const mukca_dataset *data,
                      int socket, int without)
{
    int n = 0;
    memset(mean, 0, 3 * sizeof *mean);
    for (int i = 0; i < data->n_rows; i++) {
        double x[3];
        if (data->socket[i] != socket || i == without) continue;
        mukca_fk_position(x, geometry, data->q + i * data->n_joints, NULL);
        for (int k = 0; k < 3; k++) mean[k] += x[k];
        n++;
    }
    for (int k = 0; k < 3 && n; k++) mean[k] /= n;
    return n;
}
