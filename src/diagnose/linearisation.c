/* Linearisation of the predictions: levers, columns of geometry and of causes. */
#include "diagnose/linearisation.h"

#include <math.h>
#include <string.h>

#include "math/dense.h"

bool mukca_linearisation_create(mukca_linearisation *linear, mukca_pool *pool,
                                const mukca_recording *recording, const mukca_unknowns *unknowns)
{
    const int rows = recording->data->n_rows, n_joints = recording->chain->n_joints,
              d = recording->dim, size = mukca_unknowns_capacity(unknowns) + 1;
    const int pairs = recording->data->n_distances + 1, groups = recording->data->n_sockets + 2;
    *linear = (mukca_linearisation){
        .recording = recording,
        .cause = MUKCA_TAKE(pool, mukca_candidate, MUKCA_MAX_ACCEPTED),
        .explained = MUKCA_TAKE(pool, double, size),
        .tip = MUKCA_TAKE(pool, double, 3 * rows),
        .tip_frame = MUKCA_TAKE(pool, double, 9 * rows),
        .seated = MUKCA_TAKE(pool, double, rows *n_joints),
        .distance = MUKCA_TAKE(pool, double, rows),
        .seated_frame = MUKCA_TAKE(pool, double, 9 * rows),
        .mean = MUKCA_TAKE(pool, double[3], groups),
        .direction = MUKCA_TAKE(pool, double[3], pairs),
        .lever = MUKCA_TAKE(pool, double, rows *n_joints *d),
        .rotation_lever = MUKCA_TAKE(pool, double, 3 * rows * n_joints * d),
        .base_lever = MUKCA_TAKE(pool, double, 3 * rows * d),
        .columns = MUKCA_TAKE(pool, double, (size_t)(rows * d) * (size_t)size),
        .pair_columns = MUKCA_TAKE(pool, double, pairs *size)};
    return !pool->failed;
}

/* Measured minus predicted of sample i of a pose log, in the base frame. */
static void pose_residual(double *y, const mukca_linearisation *linear,
                          const mukca_unknowns *unknowns, int i)
{
    const mukca_recording *recording = linear->recording;
    const size_t row = (size_t)recording->order[i];
    const double *p = linear->tip + 3 * i, *R = linear->tip_frame + 9 * i;
    const int log = recording->log[row];
    const double *tracker = unknowns->arm.log.tracker[log].R;
    mukca_unknowns_to_base(y, unknowns, log, recording->data->position + 3 * row);
    for (int c = 0; c < 3; c++) y[c] -= p[c];
    if (recording->dim < 6) return;
    double measured[9], base[9], w[3];
    mukca_rotation_from_quaternion(measured, recording->data->quaternion + 4 * row);
    mukca_mat3_tmul(base, tracker, measured);
    mukca_rotation_difference(w, base, R);
    for (int c = 0; c < 3; c++) y[3 + c] = unknowns->rotation_weight * w[c];
}

/* Move the tip's frame to the log's own target. */
static void to_target(mukca_frame *tip, const mukca_unknowns *u, int log)
{
    const mukca_frame *shift = &u->arm.log.shift[log];
    if (log > 0 && u->n_targets > 1) mukca_frame_multiply(tip, tip, shift);
}

/* What is computed for samples independently, some at a time. */
typedef struct {
    mukca_linearisation *linear;
    const mukca_unknowns *unknowns;
} update;

enum { TOGETHER = 64 };

static int end_of(const mukca_recording *recording, int block)
{
    const int end = (block + 1) * TOGETHER;
    return end < recording->n_samples ? end : recording->n_samples;
}

static void run(update *u, mukca_block_fn *samples)
{
    const mukca_recording *r = u->linear->recording;
    mukca_workers_run(r->workers, (r->n_samples + TOGETHER - 1) / TOGETHER, samples, u);
}

/* Predictions of samples. */
static void predict(void *context, int block, int worker)
{
    const update *of = context;
    const mukca_recording *recording = of->linear->recording;
    const mukca_unknowns *unknowns = of->unknowns;
    mukca_linearisation *linear = of->linear;
    const int n_joints = recording->chain->n_joints;
    (void)worker;
    for (int i = block * TOGETHER; i < end_of(recording, block); i++) {
        const int row = recording->order[i];
        mukca_frame tip;
        mukca_displacement displacement;
        mukca_unknowns_displacement(&displacement, unknowns, n_joints, row);
        mukca_fk_pose(&tip, &unknowns->arm.geometry, recording->data->q + row * n_joints,
                      &displacement);
        to_target(&tip, unknowns, recording->log[row]);
        memcpy(linear->tip + 3 * i, tip.p, sizeof tip.p);
        memcpy(linear->tip_frame + 9 * i, tip.R, sizeof tip.R);
    }
}

/* Means of the groups of predictions, and directions between paired sockets. */
static void find_directions(mukca_linearisation *linear)
{
    const mukca_recording *recording = linear->recording;
    for (int g = 0; g < recording->n_groups; g++) {
        const mukca_group *group = &recording->groups[g];
        double *mean = linear->mean[g];
        memset(mean, 0, sizeof linear->mean[g]);
        for (int i = group->start; i < group->start + group->count; i++)
            for (int c = 0; c < 3; c++) mean[c] += linear->tip[3 * i + c] / group->count;
    }
    for (int p = 0; p < recording->n_pairs; p++) {
        const double *a = linear->mean[recording->pairs[p].a];
        const double *b = linear->mean[recording->pairs[p].b];
        double *direction = linear->direction[p];
        for (int c = 0; c < 3; c++) direction[c] = a[c] - b[c];
        const double length = fmax(sqrt(mukca_dot3(direction, direction)), 1e-9);
        for (int c = 0; c < 3; c++) direction[c] /= length;
    }
}

/* r := vector from the predicted position of sample i to its socket's mean plus the socket's
 * faults. */
static void socket_error(double r[3], const mukca_linearisation *linear,
                         const mukca_unknowns *unknowns, int g, int i)
{
    const mukca_recording *recording = linear->recording;
    for (int c = 0; c < 3; c++) r[c] = linear->mean[g][c] - linear->tip[3 * i + c];
    for (int c = 0; c < unknowns->n_causes; c++) {
        const mukca_accepted *cause = &unknowns->cause[c];
        if (!mukca_candidate_is_fault(&cause->candidate)) continue;
        const double displaced =
            mukca_candidate_fault_share(&cause->candidate, recording, recording->order[i]);
        for (int k = 0; k < 3; k++) r[k] += displaced * cause->coefficient[k];
    }
}

/* Columns are computed at the seated angles: at the recorded ones they would correlate with the
 * noise of their own sample, and the regression would shrink the arm to reduce the noise. */
void mukca_linearisation_seat(double *seated, double r[3], int n, const mukca_geometry *geometry,
                              const mukca_displacement *displacement)
{
    double J[6 * MUKCA_MAX_JOINTS], A[9];
    mukca_fk_jacobian(J, NULL, geometry, seated, displacement);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            A[3 * a + b] = a == b ? 1e-4 : 0; /* (1 cm per rad)^2: damps singular postures */
            for (int j = 0; j < n; j++) A[3 * a + b] += J[a * n + j] * J[b * n + j];
        }
    if (!mukca_dense_solve(r, 1, A, 3)) return;
    for (int j = 0; j < n; j++)
        for (int c = 0; c < 3; c++) seated[j] += J[c * n + j] * r[c];
}

/* turn[6][3] := derivative of the tip (position, weighted orientation) by a rotation of a frame. */
static void turn_of(double turn[6][3], const mukca_frame *frame, const double tip[3],
                    double rotation_weight)
{
    double arm[3];
    for (int c = 0; c < 3; c++) arm[c] = tip[c] - frame->p[c];
    for (int a = 0; a < 3; a++) {
        const double axis[3] = {frame->R[a], frame->R[3 + a], frame->R[6 + a]};
        double cross[3];
        mukca_cross(cross, axis, arm);
        for (int c = 0; c < 3; c++) {
            turn[c][a] = cross[c];
            turn[3 + c][a] = rotation_weight * axis[c];
        }
    }
}

/* Levers and geometry columns of sample i at the angles q.  The common factor scales the nominal
 * origins: not the travel of a sliding joint, a measured target or the offsets. */
static void fill_sample(mukca_linearisation *linear, const mukca_unknowns *u, int i,
                        const double *q, const mukca_displacement *displacement)
{
    const mukca_recording *recording = linear->recording;
    const mukca_chain *chain = recording->chain;
    const int d = recording->dim, ld = linear->stride, log = recording->log[recording->order[i]];
    double *X = linear->columns + (size_t)i * (size_t)d * (size_t)ld;
    double *base_lever = linear->base_lever + (size_t)i * (size_t)(3 * d);
    mukca_frame before[MUKCA_MAX_ELEMENTS], tip;
    mukca_fk_frames(before, &tip, &u->arm.geometry, q, displacement);
    to_target(&tip, u, log);
    memset(X, 0, sizeof *X * (size_t)d * (size_t)ld);
    double turn[6][3];
    turn_of(turn, &(mukca_frame){.R = MUKCA_IDENTITY}, tip.p, u->rotation_weight);
    memcpy(base_lever, turn, sizeof *turn * (size_t)d);
    double length[3], local[3], factor[3] = {0};
    memcpy(linear->seated_frame + 9 * i, tip.R, sizeof tip.R);
    int slot = 0;
    for (int k = 0; k < chain->n_elements; k++) {
        const mukca_element *element = &chain->element[k];
        const double *R = before[k].R;
        mukca_mat3_tvec(local, u->arm.geometry.origin[k].R, element->xyz);
        mukca_mat3_vec(length, R, local);
        for (int c = 0; c < 3; c++) factor[c] += length[c];
        const bool free = slot < u->n_slots && u->slot_element[slot] == k;
        if (!free && element->joint < 0) continue;
        turn_of(turn, &before[k], tip.p, u->rotation_weight);
        if (element->joint >= 0) {
            const size_t at = (size_t)(i * chain->n_joints + element->joint) * (size_t)d;
            for (int c = 0; c < d; c++) {
                memcpy(linear->rotation_lever + 3 * (at + (size_t)c), turn[c], sizeof turn[c]);
                double along = mukca_dot3(turn[c], element->axis);
                if (element->type == MUKCA_PRISMATIC)
                    along = c < 3 ? mukca_dot3(R + 3 * c, element->axis) : 0;
                linear->lever[at + (size_t)c] = along;
            }
        }
        if (!free) continue;
        const int width = slot + 1 < u->n_slots ? 6 : u->slot_width;
        for (int c = 0; c < d; c++)
            for (int a = 0; a < 3; a++) {
                if (c < 3) X[c * ld + 6 * slot + a] = R[3 * c + a];
                if (width == 6) X[c * ld + 6 * slot + 3 + a] = turn[c][a];
            }
        slot++;
    }
    for (int c = 0; c < 3; c++) X[c * ld + u->first_tracker - 1] = factor[c];
    for (int a = 0; u->free_base && a < 3; a++) {
        double *frame = X + u->first_tracker + (u->n_trackers > 1 ? 6 * log : 0) + a;
        frame[a * ld] = 1;
        for (int c = 0; c < d; c++) frame[c * ld + 3] = base_lever[c * 3 + a];
    }
    for (int a = 0; u->n_targets > 1 && log > 0 && a < 3; a++) {
        double *shift = X + u->first_target + u->slot_width * (log - 1) + a;
        for (int c = 0; c < 3; c++) {
            shift[c * ld] = tip.R[3 * c + a];
            if (u->slot_width == 6) shift[(3 + c) * ld + 3] = u->rotation_weight * tip.R[3 * c + a];
        }
    }
}

/* y = measured - predicted + contribution of the present unknowns, less the centres of known
 * priors: solutions are total values. */
static void fill_y(void *context, int block, int worker)
{
    const update *of = context;
    const mukca_recording *recording = of->linear->recording;
    const mukca_linearisation *linear = of->linear;
    const int d = recording->dim, ld = linear->stride, n = linear->n_columns;
    (void)worker;
    for (int i = block * TOGETHER; i < end_of(recording, block); i++) {
        double y[6] = {0}, *X = linear->columns + (size_t)i * (size_t)d * (size_t)ld;
        if (recording->data->socket[recording->order[i]] < 0)
            pose_residual(y, linear, of->unknowns, i);
        else
            for (int c = 0; c < 3; c++) y[c] = -linear->tip[3 * i + c];
        for (int c = 0; c < d; c++) {
            double sum = y[c];
            for (int k = 0; k < n; k++) sum += X[c * ld + k] * linear->explained[k];
            X[c * ld + n] = sum;
        }
    }
}

/* Store the columns of a cause from column `at` on. */
static void store_cause(mukca_linearisation *linear, const mukca_candidate *h, int at)
{
    const mukca_recording *recording = linear->recording;
    const int ld = linear->stride;
    linear->cause[linear->n_causes++] = *h;
    mukca_linearisation_columns(linear->columns + at, ld, linear, h);
    for (int p = 0; p < recording->n_pairs; p++)
        for (int t = 0; t < h->terms; t++)
            linear->pair_columns[p * ld + at + t] =
                mukca_candidate_changes_pair(h, recording, p) ? -1 : 0;
}

/* Levers, and columns of the geometry. */
static void fill_geometry(void *context, int block, int worker)
{
    const update *of = context;
    const mukca_recording *recording = of->linear->recording;
    const mukca_unknowns *u = of->unknowns;
    mukca_linearisation *linear = of->linear;
    const int n = recording->chain->n_joints;
    int g = 0;
    (void)worker;
    for (int i = block * TOGETHER; i < end_of(recording, block); i++) {
        while (i >= recording->groups[g].start + recording->groups[g].count) g++;
        const bool seat = recording->groups[g].socket >= 0;
        const int row = recording->order[i];
        double *seated = linear->seated + i * n, r[6];
        mukca_displacement displacement;
        mukca_unknowns_displacement(&displacement, u, n, row);
        memcpy(seated, recording->data->q + row * n, sizeof *seated * (size_t)n);
        if (seat)
            socket_error(r, linear, u, g, i);
        else
            pose_residual(r, linear, u, i);
        linear->distance[i] = sqrt(mukca_dot3(r, r));
        mukca_linearisation_seat(seated, r, n, &u->arm.geometry, &displacement);
        /* far from the solution, frames of a pose log would turn into angles */
        fill_sample(linear, u, i, seat ? seated : recording->data->q + row * n, &displacement);
    }
}

void mukca_linearisation_update(mukca_linearisation *linear, mukca_unknowns *u)
{
    const mukca_recording *recording = linear->recording;
    const int n = mukca_unknowns_column(u, u->n_causes);
    update of = {linear, u};
    linear->n_columns = linear->y = n;
    linear->stride = n + 1;
    linear->n_causes = 0;
    linear->version++;
    mukca_unknowns_set_geometry(u, recording->chain);
    run(&of, predict);
    find_directions(linear);
    run(&of, fill_geometry);
    for (int p = 0; p < recording->n_pairs; p++) {
        double *pair = linear->pair_columns + p * linear->stride;
        memset(pair, 0, sizeof *pair * (size_t)n);
        pair[u->first_artefact + recording->pairs[p].artefact] = -1;
        pair[n] = recording->pairs[p].distance;
    }
    memcpy(linear->explained, u->theta, sizeof *u->theta * (size_t)u->n_geometry);
    for (int c = 0, at = u->n_geometry; c < u->n_causes; c++) {
        const mukca_accepted *cause = &u->cause[c];
        store_cause(linear, &cause->candidate, at);
        for (int t = 0; t < cause->candidate.terms; t++, at++)
            /* A socket's fault moves the socket, not the arm: `tip` does not include it. */
            linear->explained[at] = mukca_candidate_moves_arm(&cause->candidate)
                                        ? cause->coefficient[t] - cause->centre
                                        : 0;
    }
    run(&of, fill_y);
}
