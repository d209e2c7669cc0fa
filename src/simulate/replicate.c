/* Replicates of a recording. */
#include "simulate/simulate.h"

#include <math.h>
#include <string.h>

#include "arm/inverse.h"
#include "base/pool.h"
#include "model/dataset_subset.h"

enum { DIM = 6, SWEEPS = 50 };

/* Tolerance of the ball's position, m. */
static const double seated = 1e-10;

typedef struct {
    const mukca_replicate_task *task;
    mukca_dataset *data;
    mukca_random random;
    mukca_row_state rows;
    mukca_joint_state state;     /* of the present sample */
    double (*seat)[3];           /* [n_sockets] */
    int *first, *last, *count;   /* [n_sockets] rows of the first and last sample, their number */
    double (*own)[DIM];          /* [n_sockets + 1] AR(1) process of each socket, of the poses */
    double (*common)[DIM];       /* [n_rows] of a posture, at its first row */
    unsigned char *begun, *seen; /* [n_sockets + 1], [n_rows] */
    double *move;                /* [n_rows][n_joints] from the posture before, rad or m */
    int *repeat;                 /* [n_rows] readings since the arm arrived */
} replicate;

static void displace(mukca_displacement *displacement, const double *q, void *context)
{
    const replicate *r = context;
    const mukca_corrected *arm = r->task->arm;
    mukca_effects_displacement(displacement, arm->effects, arm->n_effects, &arm->chain,
                               &arm->geometry, q, &r->state);
}

/* Joint state of a sample. */
static void enter(replicate *r, int row)
{
    r->state = *mukca_dataset_state(&r->rows, r->data, row);
    r->state.move = r->move + row * r->data->n_joints;
    r->state.repeat = r->repeat[row];
}

/* Shift of a socket in a sample. */
static void find_shift(double shift[3], const replicate *r, int row)
{
    const mukca_dataset *d = r->data;
    memset(shift, 0, 3 * sizeof *shift);
    for (int i = 0; i < r->task->n_motions; i++) {
        const mukca_replicate_motion *m = &r->task->motions[i];
        const int s = m->socket;
        if (d->socket[row] != s) continue;
        const double share =
            m->row > 0
                ? d->file[row] > m->file || (d->file[row] == m->file && d->row[row] >= m->row)
                : (double)(row - r->first[s]) / fmax(r->last[s] - r->first[s], 1);
        for (int a = 0; a < 3; a++) shift[a] += share * m->shift[a];
    }
}

/* Distance of a pair of sockets on the true arm. */
static double true_distance(const replicate *r, const mukca_distance *pair)
{
    const mukca_corrected *arm = r->task->arm;
    double distance = pair->distance;
    for (int e = 0; e < arm->n_effects; e++)
        if (mukca_effect_table[arm->effects[e].kind]->site == MUKCA_SITE_DISTANCE &&
            (arm->effects[e].placement < 0 ||
             arm->effects[e].placement == r->data->sockets[pair->a].placement))
            distance += arm->effects[e].coefficient[0];
    return distance;
}

/* Positions of the sockets: means of the ball's positions at the recorded angles, then the nearest
 * ones with the known distances. */
static void find_seats(replicate *r)
{
    const mukca_dataset *d = r->data;
    for (int row = d->n_rows - 1; row >= 0; row--) {
        const int s = d->socket[row];
        if (s < 0) continue;
        if (r->last[s] == 0) r->last[s] = row;
        r->first[s] = row;
    }
    for (int row = 0; row < d->n_rows; row++) {
        const double *q = d->q + row * d->n_joints;
        const int s = d->socket[row];
        mukca_displacement displacement;
        double p[3], shift[3];
        if (s < 0) continue;
        enter(r, row);
        displace(&displacement, q, r);
        mukca_fk_position(p, &r->task->arm->geometry, q, &displacement);
        find_shift(shift, r, row);
        r->count[s]++;
        for (int a = 0; a < 3; a++)
            r->seat[s][a] += (p[a] - shift[a] - r->seat[s][a]) / r->count[s];
    }
    for (int i = 0; i < SWEEPS * d->n_distances; i++) {
        const mukca_distance *pair = &d->distances[i % d->n_distances];
        double *a = r->seat[pair->a], *b = r->seat[pair->b];
        if (!r->count[pair->a] || !r->count[pair->b]) continue;
        const double between[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        const double by = 0.5 * (true_distance(r, pair) / mukca_norm3(between) - 1);
        for (int c = 0; c < 3 && isfinite(by); c++)
            a[c] -= by * between[c], b[c] += by * between[c];
    }
}

/* Noise of a sample in units of its sigma. */
static void draw(double noise[DIM], replicate *r, int row)
{
    const int s = r->data->socket[row] < 0 ? r->data->n_sockets : r->data->socket[row];
    const int posture = r->task->posture[row];
    const double rho = r->begun[s] ? r->task->correlation : 0, shared = r->task->shared;
    for (int a = 0; a < DIM; a++) {
        r->own[s][a] = rho * r->own[s][a] + sqrt(1 - rho * rho) * mukca_random_normal(&r->random);
        if (!r->seen[posture]) r->common[posture][a] = mukca_random_normal(&r->random);
        noise[a] = sqrt(1 - shared) * r->own[s][a] + sqrt(shared) * r->common[posture][a];
    }
    r->begun[s] = r->seen[posture] = 1;
}

/* Angles that bring the true ball into its socket, nearest to the recorded ones. */
static void seat_ball(replicate *r, int row, const double noise[DIM])
{
    const mukca_corrected *arm = r->task->arm;
    const mukca_inverse_options options = {.tolerance = seated, .displace = displace, .context = r};
    const size_t n = (size_t)r->data->n_joints, at = (size_t)row * n;
    double q[MUKCA_MAX_JOINTS], shift[3];
    mukca_frame target = {{0}, {0}};
    find_shift(shift, r, row);
    for (int a = 0; a < 3; a++)
        target.p[a] = r->seat[r->data->socket[row]][a] + shift[a] + r->task->noise * noise[a];
    memcpy(q, r->data->q + at, n * sizeof *q);
    mukca_inverse_solve(q, &arm->chain, &arm->geometry, &target, false, &options);
    for (size_t j = 0; j < n; j++) {
        const double change = q[j] - r->data->q[at + j];
        r->data->q[at + j] = q[j];
        if (r->data->command) r->data->command[at + j] += change;
        if (r->data->reading) r->data->reading[at + j] += change;
    }
}

/* The measured pose; values that were not measured stay NaN. */
static void measure_pose(replicate *r, int row, const double noise[DIM])
{
    const double *q = r->data->q + row * r->data->n_joints;
    double *position = r->data->position + 3 * row, w[3], turn[9], R[9];
    mukca_displacement displacement;
    mukca_frame pose;
    displace(&displacement, q, r);
    mukca_fk_pose(&pose, &r->task->arm->geometry, q, &displacement);
    mukca_frame_multiply(&pose, &r->task->tracker, &pose);
    for (int a = 0; a < 3; a++) {
        if (isfinite(position[a])) position[a] = pose.p[a] + r->task->noise * noise[a];
        w[a] = r->task->rotation * noise[3 + a];
    }
    if (!r->data->quaternion || !isfinite(r->data->quaternion[4 * row])) return;
    mukca_rotation_exp(turn, w);
    mukca_mat3_mul(R, pose.R, turn);
    mukca_rotation_to_quaternion(r->data->quaternion + 4 * row, R);
}

mukca_status mukca_simulate_replicate(mukca_dataset *out, const mukca_replicate_task *task,
                                      uint64_t seed, mukca_error *error)
{
    const int rows = task->data->n_rows, sockets = task->data->n_sockets;
    mukca_pool pool = {0};
    replicate r = {.task = task,
                   .data = out,
                   .seat = mukca_pool_take(&pool, (size_t)sockets, sizeof *r.seat),
                   .first = MUKCA_TAKE(&pool, int, sockets),
                   .last = MUKCA_TAKE(&pool, int, sockets),
                   .count = MUKCA_TAKE(&pool, int, sockets),
                   .own = mukca_pool_take(&pool, (size_t)sockets + 1, sizeof *r.own),
                   .common = mukca_pool_take(&pool, (size_t)rows, sizeof *r.common),
                   .begun = MUKCA_TAKE(&pool, unsigned char, sockets + 1),
                   .seen = MUKCA_TAKE(&pool, unsigned char, rows),
                   .move = MUKCA_TAKE(&pool, double, rows * task->data->n_joints),
                   .repeat = MUKCA_TAKE(&pool, int, rows)};
    unsigned char *keep = MUKCA_TAKE(&pool, unsigned char, rows);
    mukca_status status = MUKCA_OK;
    if (!pool.failed)
        mukca_postures_move(r.move, r.repeat, &pool, task->posture, task->data, task->data->q);
    if (pool.failed)
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", rows);
    else
        memset(keep, 1, (size_t)rows);
    if (status == MUKCA_OK) status = mukca_dataset_subset(out, task->data, keep, error);
    if (status == MUKCA_OK) {
        mukca_simulate_seed(&r.random, seed, MUKCA_DRAW_NOISE);
        find_seats(&r);
    }
    for (int row = 0; row < rows && status == MUKCA_OK; row++) {
        double noise[DIM];
        enter(&r, row);
        draw(noise, &r, row);
        if (out->socket[row] >= 0)
            seat_ball(&r, row, noise);
        else if (out->position)
            measure_pose(&r, row, noise);
    }
    mukca_pool_free(&pool);
    return status;
}
