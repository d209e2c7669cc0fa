/* Postures: rows of a recording with the same joint angles; random ones. */
#include "model/dataset_subset.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "math/stats.h"

/* Distances between readings of one posture and between postures, rad (m of a sliding joint):
 * encoder noise and servo steps are below the one, chosen postures above the other.  Between them
 * the widest gap in the data decides: a ball that is put back into its socket follows what drifted
 * since the last round, 10 mrad for 5 mm at half a metre. */
#define NEAR 0.2e-3
#define FAR 50e-3

enum {
    SAMPLED = 2000, /* rows in which the gap is searched: time linear in all rows */
    HASHED = 8,     /* joints, the first of the arm, that determine a bucket */
    NEAR_BUCKETS = 1 << HASHED
};

/* Rows by the hash of their angles, rounded to cells.  A cell is more than two radii wide, so that
 * a row's neighbours are in two cells a joint at most, in 1 + 2 radii / width on average: in 3
 * buckets in all where the width is two radii for each joint. */
typedef struct {
    const mukca_dataset *d;
    double per_cell;   /* 1 / width of a cell */
    int *first, *next; /* of a bucket [1 << bits]; of a row; -1: none */
    int joints, bits;
} buckets;

static void start(buckets *b, mukca_pool *pool, const mukca_dataset *d, double radius, int rows)
{
    const int joints = d->n_joints < HASHED ? d->n_joints : HASHED;
    *b = (buckets){.d = d, .joints = joints, .bits = 2};
    b->per_cell = 1 / (radius * fmax(3, 2 * joints));
    while (b->bits < 30 && 1 << (b->bits - 2) < rows) b->bits++;
    b->first = MUKCA_TAKE(pool, int, 1 << b->bits);
    b->next = MUKCA_TAKE(pool, int, d->n_rows);
    for (int i = 0; i < 1 << b->bits && !pool->failed; i++) b->first[i] = -1;
}

/* The nearest integer, plus a constant: the low bits of x + 1.5 * 2^52. */
static uint64_t to_cell(double x)
{
    const double shifted = x + 0x1.8p52;
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    return bits;
}

/* found[NEAR_BUCKETS] := the buckets within `radius` of a row.  Returns their number.  Hash: sum of
 * cells times odd numbers, the powers of 2^64 / golden ratio (Fibonacci hashing: Knuth, The Art of
 * Computer Programming 3, section 6.4). */
static int find_buckets(unsigned *found, const buckets *b, int row, double radius)
{
    const double *q = b->d->q + (size_t)row * (size_t)b->d->n_joints;
    uint64_t hash[NEAR_BUCKETS], odd = 1;
    int n = 1;
    hash[0] = 0;
    for (int j = 0; j < b->joints; j++) {
        odd *= 0x9e3779b97f4a7c15u;
        const uint64_t low = to_cell((q[j] - radius) * b->per_cell);
        const uint64_t more = to_cell((q[j] + radius) * b->per_cell) - low;
        for (int i = 0; i < n; i++) {
            hash[i] += low * odd;
            if (more) hash[n + i] = hash[i] + more * odd;
        }
        n += more ? n : 0;
    }
    for (int i = 0; i < n; i++) found[i] = (unsigned)(hash[i] >> (64 - b->bits));
    return n;
}

static void add(buckets *b, int row)
{
    unsigned bucket;
    find_buckets(&bucket, b, row, 0);
    b->next[row] = b->first[bucket];
    b->first[bucket] = row;
}

/* Largest difference of a joint's angles; rows with another payload are another posture. */
static double distance(const mukca_dataset *d, int a, int b)
{
    const size_t n = (size_t)d->n_joints;
    if (d->payload && d->payload[a] != d->payload[b] &&
        !(isnan(d->payload[a]) && isnan(d->payload[b])))
        return HUGE_VAL;
    return mukca_largest_difference(d->q + (size_t)a * n, d->q + (size_t)b * n, d->n_joints);
}

/* Largest distance of readings of one posture: the middle, in logarithms, of the widest gap in the
 * distances of some rows to the nearest other one. */
static double find_tolerance(mukca_pool *pool, const mukca_dataset *d)
{
    const int step = 1 + d->n_rows / SAMPLED;
    double *nearest = MUKCA_TAKE(pool, double, SAMPLED + 1);
    unsigned near[NEAR_BUCKETS];
    buckets b;
    int n = 0;
    start(&b, pool, d, FAR, SAMPLED);
    if (pool->failed) return 0;
    for (int i = 0; i < d->n_rows; i += step) add(&b, i), nearest[i / step] = FAR;
    for (int row = 0; row < d->n_rows; row++)
        for (int k = find_buckets(near, &b, row, FAR) - 1; k >= 0; k--)
            for (int i, *at = &b.first[near[k]]; (i = *at) >= 0;) {
                double *least = &nearest[i / step];
                const double far = i == row ? FAR : distance(d, i, row);
                if (far < *least) *least = far;
                if (*least > NEAR)
                    at = &b.next[i];
                else
                    *at = b.next[i];
            }
    for (int i = 0; i < d->n_rows; i += step)
        if (nearest[i / step] > NEAR && nearest[i / step] < FAR) nearest[n++] = nearest[i / step];
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
    const double tolerance = find_tolerance(pool, d);
    unsigned near[NEAR_BUCKETS];
    int repeats = 0;
    buckets b;
    if (!pool->failed) start(&b, pool, d, tolerance, d->n_rows);
    if (pool->failed) return 0;
    for (int row = 0; row < d->n_rows; row++) {
        double least = tolerance;
        posture[row] = row;
        for (int k = find_buckets(near, &b, row, tolerance) - 1; k >= 0; k--)
            for (int other = b.first[near[k]]; other >= 0; other = b.next[other]) {
                const double far = distance(d, row, other);
                if (far < least) least = far, posture[row] = other;
            }
        if (posture[row] == row)
            add(&b, row);
        else
            repeats++;
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
            double *value = &mean[posture[row] * n + j];
            *value += (q[row * n + j] - *value) / (count[posture[row]] + 1);
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
