/* Recording of a simulated arm, sample by sample. */
#include "simulate/simulate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arm/inverse.h"
#include "fit/parameters.h"
#include "mukca/gravity.h"

/* Attempts per sample, and tolerance of the ball's position (m). */
enum { ATTEMPTS = 200 };
static const double seated = 1e-12;
/* Mean time between samples, s. */
static const double interval = 5;

void mukca_simulate_perturb(double *theta, unsigned char *listed, const mukca_chain *chain,
                            double shift, double turn, uint64_t seed)
{
    mukca_random random;
    mukca_parameters free;
    mukca_simulate_seed(&random, seed, MUKCA_DRAW_GEOMETRY);
    mukca_parameters_set(&free, chain, NULL, false);
    for (int i = 0; i < free.n; i++) {
        const int k = free.index[i];
        theta[k] += (k % MUKCA_PARAMETERS < 3 ? shift : turn) * mukca_random_normal(&random);
        if (listed) listed[k] = 1;
    }
}

void mukca_simulate_arm(mukca_corrected *arm, const mukca_chain *chain, const double *theta)
{
    arm->chain = *chain;
    arm->n_effects = 0;
    mukca_geometry_set(&arm->geometry, chain, theta);
}

/* ---- one sample ---- */

/* State of a recording. */
typedef struct {
    const mukca_corrected *arm;
    mukca_dataset *data;
    mukca_simulate_options options;
    mukca_row_state states;
    mukca_random postures, noise, rotation, clock;
    double lag; /* readback lag along the last move, rad */
    int row;
} recorder;

/* Displacement by the effects at angles q in the present sample. */
static void displace(mukca_displacement *displacement, const double *q, void *context)
{
    const mukca_effect last_move = {.kind = mukca_effect_at(MUKCA_SITE_ANGLES, 0)};
    recorder *r = context;
    const int n = r->data->n_joints;
    double meant[MUKCA_MAX_JOINTS]; /* commands of a controller whose readings lag */
    mukca_joint_state state = *mukca_row_state_set(&r->states, q);
    mukca_effect_direction(meant, n, &last_move, &state);
    for (int j = 0; j < n; j++) meant[j] = q[j] + r->lag * meant[j];
    state.command = meant;
    if (r->data->command)
        memcpy(r->data->command + (size_t)r->row * (size_t)n, meant, (size_t)n * sizeof *meant);
    mukca_effects_displacement(displacement, r->arm->effects, r->arm->n_effects, &r->arm->chain,
                               &r->arm->geometry, &state);
}

/* Replace the angles of the sample, the commands so far, by the readings of the sagging joints. */
static void read_sag(recorder *r)
{
    const size_t n = (size_t)r->data->n_joints, at = (size_t)r->row * n;
    double *q = r->data->q + at;
    mukca_displacement sag;
    mukca_effect sagging[MUKCA_MAX_EFFECTS];
    int count = 0;
    for (int e = 0; e < r->arm->n_effects; e++)
        if (mukca_effect_table[r->arm->effects[e].kind]->needs & MUKCA_NEEDS_COMMANDS)
            sagging[count++] = r->arm->effects[e];
    if (count == 0) return;
    mukca_effects_displacement(&sag, sagging, count, &r->arm->chain, &r->arm->geometry,
                               &r->states.state);
    for (size_t j = 0; j < n; j++) q[j] += sag.q[j];
}

/* Fill the columns that depend on the sample's angles, and advance to the next sample. */
static void finish_row(recorder *r)
{
    mukca_dataset *data = r->data;
    const size_t n = (size_t)data->n_joints, at = (size_t)r->row * n;
    const double *q = data->q + at;
    mukca_row_state_set(&r->states, q);
    if (data->command) {
        mukca_displacement ignored;
        displace(&ignored, q, r);
        read_sag(r);
    }
    if (data->effort) {
        mukca_gravity_load load;
        mukca_chain_moments(&load, &r->arm->chain, &r->arm->geometry, q, NULL, r->options.payload);
        for (size_t j = 0; j < n; j++) data->effort[at + j] = load.torque[j];
    }
    r->row++;
}

/* Start a sample `pause` s after the preceding one, with jitter, unless it is interrupted. */
static mukca_status tick(recorder *r, double pause)
{
    if (r->options.interrupted && r->options.interrupted()) return MUKCA_INTERRUPTED;
    double *t = r->data->time + r->row;
    const double jitter = 0.6 + 0.8 * mukca_random_uniform(&r->clock);
    *t = r->row > 0 ? t[-1] + round(1e3 * pause * jitter) / 1e3 : 0;
    const mukca_row_reading reading = {.q = r->data->q + (size_t)r->row * (size_t)r->data->n_joints,
                                       .time = *t,
                                       .payload_kg = r->options.payload,
                                       .placement = mukca_dataset_placement(r->data, r->row),
                                       .number = r->row + 1};
    mukca_row_state_next(&r->states, &reading);
    return MUKCA_OK;
}

/* Add a column of n numbers, if it is wanted; false: out of memory. */
static bool add_column(double **column, bool wanted, size_t n)
{
    if (wanted) *column = calloc(n, sizeof **column);
    return !wanted || *column;
}

/* Start a recording of `rows` samples; without placements it has no sockets. */
static mukca_status begin(recorder *r, mukca_dataset *data, int rows, int placements,
                          mukca_error *error)
{
    const mukca_corrected *arm = r->arm;
    const size_t n = (size_t)arm->chain.n_joints, count = (size_t)rows;
    const bool loaded = r->options.payload > 0;
    r->data = data;
    mukca_row_state_start(&r->states, arm->chain.n_joints);
    const uint64_t seed = r->options.seed;
    mukca_simulate_seed(&r->postures, seed, MUKCA_DRAW_POSTURES);
    mukca_simulate_seed(&r->noise, seed, MUKCA_DRAW_NOISE);
    mukca_simulate_seed(&r->rotation, seed, MUKCA_DRAW_ROTATION);
    mukca_simulate_seed(&r->clock, seed, MUKCA_DRAW_TIME);
    for (size_t i = 0; i < 2 * n; i++) mukca_random_uniform(&r->postures); /* keeps the bytes */
    bool compared = false;
    for (int e = 0; e < arm->n_effects; e++) {
        const mukca_effect *effect = &arm->effects[e];
        if (mukca_effect_table[effect->kind]->site != MUKCA_SITE_ANGLES) continue;
        compared |= effect->variant.to_command;
        if (!effect->variant.to_command) r->lag += effect->coefficient[0];
    }
    if (compared && r->lag == 0) r->lag = 1e-3;
    MUKCA_TRY(mukca_dataset_create(data, rows, (int)n, 2 * placements, placements, error));
    if (!add_column(&data->time, true, count) || !add_column(&data->payload, loaded, count) ||
        !add_column(&data->effort, r->options.effort, count * n) ||
        !add_column(&data->command, r->options.command, count * n))
        return mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", rows);
    for (size_t row = 0; loaded && row < count; row++) data->payload[row] = r->options.payload;
    return MUKCA_OK;
}

/* ---- sockets ---- */

void mukca_simulate_seat(double position[3], const mukca_simulated_session *session, int place,
                         int socket, int row)
{
    const mukca_corrected *arm = session->arm;
    const mukca_frame *pose = &session->places[place].pose;
    double distance = session->options->distance, shift[3] = {0, 0, 0};
    for (int e = 0; e < arm->n_effects; e++)
        if (mukca_effect_table[arm->effects[e].kind]->site == MUKCA_SITE_DISTANCE)
            distance += arm->effects[e].coefficient[0];
    int seat = socket;
    for (int f = 0; f < session->n_faults; f++) {
        const mukca_simulated_fault *fault = &session->faults[f];
        if (fault->placement != place || fault->socket != socket) continue;
        double fraction = 0;
        if (fault->kind == MUKCA_SIMULATED_WRONG_SOCKET && fault->row == row) seat = 1 - socket;
        if (fault->kind == MUKCA_SIMULATED_OUTLIER) fraction = fault->row == row;
        if (fault->kind == MUKCA_SIMULATED_STEP) fraction = row >= fault->row;
        if (fault->kind == MUKCA_SIMULATED_CREEP && row > fault->row)
            fraction = (double)(row - fault->row) / (session->options->rows - 1 - fault->row);
        for (int a = 0; a < 3; a++) shift[a] += fraction * fault->shift[a];
    }
    for (int a = 0; a < 3; a++)
        position[a] = pose->p[a] + (seat - 0.5) * distance * pose->R[3 * a] + shift[a];
}

/* Find angles that bring the true ball to `target`; false: no posture was found. */
static bool seat_ball(recorder *r, const mukca_frame *target)
{
    const size_t n = (size_t)r->data->n_joints;
    double *q = r->data->q + (size_t)r->row * n;
    const mukca_inverse_options options = {.tolerance = seated, .displace = displace, .context = r};
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        mukca_simulate_posture(q, &r->arm->chain, &r->postures);
        const mukca_inverse_result found =
            mukca_inverse_solve(q, &r->arm->chain, &r->arm->geometry, target, false, &options);
        /* Avoid joint limits, as an operator does, in the first half of the attempts. */
        if (found.reached && (!found.limited || attempt > ATTEMPTS / 2)) return true;
    }
    return false;
}

static bool is_duplicate(const mukca_simulated_session *session, int place, int socket, int row)
{
    for (int f = 0; f < session->n_faults; f++) {
        const mukca_simulated_fault *fault = &session->faults[f];
        if (fault->kind == MUKCA_SIMULATED_DUPLICATE && fault->placement == place &&
            fault->socket == socket && fault->row == row)
            return row > 0;
    }
    return false;
}

static mukca_status record_socket(recorder *r, const mukca_simulated_session *session, int place,
                                  int socket, int row, mukca_error *error)
{
    const size_t n = (size_t)r->data->n_joints;
    mukca_frame target = {{0}, {0}};
    r->data->socket[r->row] = 2 * place + socket;
    MUKCA_TRY(tick(r, row > 0 ? interval : socket ? 2 * interval : 10 * interval));
    mukca_simulate_seat(target.p, session, place, socket, row);
    for (int a = 0; a < 3; a++) target.p[a] += r->options.noise * mukca_random_normal(&r->noise);
    if (is_duplicate(session, place, socket, row)) {
        double *q = r->data->q + (size_t)r->row * n;
        memcpy(q, q - n, n * sizeof *q);
    } else if (!seat_ball(r, &target)) {
        return mukca_fail(error, MUKCA_INPUT,
                          "placement %s: the arm does not reach socket %d at "
                          "(%.3g, %.3g, %.3g) m; move the placement",
                          session->places[place].name, socket, target.p[0], target.p[1],
                          target.p[2]);
    }
    finish_row(r);
    return MUKCA_OK;
}

mukca_status mukca_simulate_sockets(mukca_dataset *data, const mukca_simulated_session *session,
                                    mukca_error *error)
{
    recorder r = {.arm = session->arm, .options = *session->options};
    const int rows = r.options.rows, n_places = session->n_places;
    mukca_status status = begin(&r, data, 2 * rows * n_places, n_places, error);
    if (status == MUKCA_OK) {
        data->distances = calloc((size_t)n_places, sizeof *data->distances);
        data->n_distances = n_places;
        if (!data->distances) status = mukca_fail(error, MUKCA_MEMORY, "out of memory");
    }
    for (int s = 0; s < 2 * n_places && status == MUKCA_OK && data->distances; s++) {
        const int p = s / 2;
        memcpy(data->placements[p].name, session->places[p].name, MUKCA_NAME_SIZE);
        data->sockets[s] = (mukca_socket){.placement = p, .label = {(char)('0' + s % 2)}};
        data->distances[p] =
            (mukca_distance){.a = 2 * p, .b = 2 * p + 1, .distance = r.options.distance};
        for (int row = 0; row < rows && status == MUKCA_OK; row++)
            status = record_socket(&r, session, p, s % 2, row, error);
    }
    if (status != MUKCA_OK) mukca_dataset_free(data);
    return status;
}

/* ---- pose logs ---- */

/* Record a pose at the angles q, NULL: at simulated ones. */
static mukca_status record_pose(recorder *r, const double *q)
{
    const size_t n = (size_t)r->data->n_joints, i = (size_t)r->row;
    double *angles = r->data->q + i * n;
    mukca_displacement displacement;
    mukca_frame pose;
    MUKCA_TRY(tick(r, interval));
    if (q)
        memcpy(angles, q, n * sizeof *q);
    else
        mukca_simulate_posture(angles, &r->arm->chain, &r->postures);
    displace(&displacement, angles, r);
    mukca_fk_pose(&pose, &r->arm->geometry, angles, &displacement);
    for (size_t a = 0; a < 3; a++)
        r->data->position[3 * i + a] =
            pose.p[a] + r->options.noise * mukca_random_normal(&r->noise);
    if (r->data->quaternion) {
        double w[3], turn[9], R[9];
        for (int a = 0; a < 3; a++) w[a] = r->options.rotation * mukca_random_normal(&r->rotation);
        mukca_rotation_exp(turn, w);
        mukca_mat3_mul(R, pose.R, turn);
        mukca_rotation_to_quaternion(r->data->quaternion + 4 * i, R);
    }
    finish_row(r);
    return MUKCA_OK;
}

mukca_status mukca_simulate_poses(mukca_dataset *data, const mukca_corrected *arm, const double *q,
                                  int n_rows, const mukca_simulate_options *options,
                                  mukca_error *error)
{
    recorder r = {.arm = arm, .options = *options};
    const size_t n = (size_t)arm->chain.n_joints, count = (size_t)n_rows;
    mukca_status status = begin(&r, data, n_rows, 0, error);
    if (status == MUKCA_OK && (!add_column(&data->position, true, 3 * count) ||
                               !add_column(&data->quaternion, !r.options.position_only, 4 * count)))
        status = mukca_fail(error, MUKCA_MEMORY, "out of memory for %d rows", n_rows);
    for (size_t i = 0; i < count && status == MUKCA_OK && data->position; i++)
        status = record_pose(&r, q ? q + i * n : NULL);
    if (status != MUKCA_OK) mukca_dataset_free(data);
    return status;
}
