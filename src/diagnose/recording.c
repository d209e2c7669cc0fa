/* The recording under diagnosis: state of its rows and groups of its samples. */
#include "diagnose/recording.h"

#include <math.h>
#include <string.h>

#include "model/dataset_subset.h"

/* One row in ten that repeats a posture is no accident. */
#define FEW_REPEATS 0.1

mukca_joint_state mukca_recording_state(const mukca_recording *r, int row)
{
    const size_t n = (size_t)r->chain->n_joints, at = (size_t)row * n;
    mukca_joint_state state = {.q = r->q + at,
                               .move = r->move + at,
                               .command = r->command ? r->command + at : NULL,
                               .torque = r->have_torques ? r->total_torque + at : NULL,
                               .time = r->time[row],
                               .repeat = r->repeat[row],
                               .placement = r->placement[row]};
    if (r->have_moments) {
        state.moment = (const double(*)[3])(r->total_moment + 3 * at);
        state.base_moment = r->total_base + 3 * row;
    }
    return state;
}

void mukca_recording_range(double range[2], const mukca_recording *r, const double *x, int columns,
                           int column)
{
    range[0] = HUGE_VAL, range[1] = -HUGE_VAL;
    for (int row = 0; row < r->data->n_rows; row++) {
        range[0] = fmin(range[0], x[row * columns + column]);
        range[1] = fmax(range[1], x[row * columns + column]);
    }
}

/* Written with comparisons: the fmin and fmax of two gathered reductions in one loop crash gcc 12's
 * vectoriser for aarch64. */
void mukca_recording_travel(double range[2], const mukca_recording *r, int joint)
{
    const int n_joints = r->chain->n_joints;
    range[0] = HUGE_VAL, range[1] = -HUGE_VAL;
    for (int i = 0; i < r->n_samples; i++) {
        const double q = r->data->q[r->order[i] * n_joints + joint];
        if (q < range[0]) range[0] = q;
        if (q > range[1]) range[1] = q;
    }
}

/* Blocks and postures of the samples in use. */
static void fill_samples(mukca_recording *r)
{
    mukca_samples *s = &r->samples;
    int *last = r->last; /* [n_rows] last sample of a posture in the present block */
    s->n_samples = r->n_samples;
    s->n_blocks = r->n_groups;
    s->dim = r->dim;
    for (int i = 0; i < r->n_samples; i++) s->next[i] = -1, s->readings[i] = 1;
    for (int g = 0; g < r->n_groups; g++) {
        const mukca_group *group = &r->groups[g];
        s->block[g] = (mukca_block){group->start, group->count, group->socket >= 0};
        for (int row = 0; row < r->data->n_rows; row++) last[row] = -1;
        for (int i = group->start; i < group->start + group->count; i++) {
            const int posture = r->posture[r->order[i]];
            if (last[posture] >= 0) s->next[last[posture]] = i, s->readings[i] = 0;
            last[posture] = i;
        }
        for (int i = group->start; i < group->start + group->count; i++)
            for (int k = i; s->readings[i] && s->next[k] >= 0; k = s->next[k]) s->readings[i]++;
    }
}

void mukca_recording_regroup(mukca_recording *r)
{
    const mukca_dataset *data = r->data;
    r->n_samples = r->n_groups = r->n_pairs = 0;
    for (int s = -1; s < data->n_sockets; s++) {
        mukca_group *group = &r->groups[r->n_groups];
        *group = (mukca_group){.start = r->n_samples, .socket = s, .placement = -1};
        for (int row = 0; row < data->n_rows; row++)
            if (r->keep[row] && data->socket[row] == s) {
                r->order[r->n_samples++] = row;
                group->placement = r->placement[row];
            }
        group->count = r->n_samples - group->start;
        /* Groups keep their index, to which faults refer: empty sockets stay in the table. */
        if (s >= 0 || group->count) r->n_groups++;
    }
    const int shift = r->groups[0].socket < 0; /* a pose log is the first group */
    for (int p = 0; p < data->n_distances; p++) {
        const mukca_distance *known = &data->distances[p];
        const mukca_socket_pair pair = {known->a + shift, known->b + shift, known->artefact,
                                        known->distance};
        if (r->groups[pair.a].count && r->groups[pair.b].count) r->pairs[r->n_pairs++] = pair;
    }
    fill_samples(r);
}

/* Fill command, time and placement of each row. */
static void fill_motion(mukca_recording *r)
{
    const size_t n = (size_t)r->chain->n_joints, size = n * sizeof(double);
    mukca_row_state rows;
    for (int row = 0; row < r->data->n_rows; row++) {
        const mukca_joint_state *state = mukca_dataset_state(&rows, r->data, row);
        const size_t at = (size_t)row * n;
        if (r->command) memcpy(r->command + at, state->command, size);
        r->time[row] = state->time;
        r->placement[row] = state->placement;
    }
}

int mukca_recording_number_logs(int *log, const mukca_dataset *data)
{
    struct {
        int file, target;
        double payload;
    } known[MUKCA_MAX_LOGS];
    int n = 0;
    for (int row = 0; row < data->n_rows; row++) {
        if (log) log[row] = 0;
        if (data->socket[row] >= 0) continue;
        /* a named target is one log in all files and with all loads */
        const int target = mukca_dataset_target(data, row),
                  file = target < 0 ? data->file[row] : -1;
        const double kg =
            target < 0 && data->payload && isfinite(data->payload[row]) ? data->payload[row] : 0;
        int i = 0;
        while (i < n && (known[i].file != file || known[i].target != target ||
                         fabs(known[i].payload - kg) > 0))
            i++;
        if (i == MUKCA_MAX_LOGS) { /* too many logs to distinguish: one */
            for (int k = 0; log && k < data->n_rows; k++) log[k] = 0;
            return 1;
        }
        if (i == n) known[n].file = file, known[n].target = target, known[n++].payload = kg;
        if (log) log[row] = i;
    }
    return n;
}

/* Values per sample: six if all rows are poses with orientations, else three. */
static int observed(const mukca_dataset *data)
{
    bool turned = data->n_rows > 0;
    for (int row = 0; row < data->n_rows && turned; row++)
        turned = data->socket[row] < 0 && data->quaternion &&
                 isfinite(data->quaternion[4 * (size_t)row]);
    return turned ? 6 : 3;
}

static void list_bodies(mukca_recording *r)
{
    const mukca_chain *chain = r->chain;
    for (int element = 0; element < chain->n_elements; element++) {
        double kg = 0;
        for (int i = 0; i < chain->n_masses; i++)
            if (chain->mass[i].element == element) kg += chain->mass[i].kg;
        if (kg > 0) r->body_element[r->n_bodies++] = element;
    }
    r->payload_body = -1;
    if (r->n_bodies == 0 || !r->data->payload) return;
    r->payload_body = r->n_bodies++;
    r->body_element[r->payload_body] = chain->n_elements - 1;
}

bool mukca_recording_create(mukca_recording *r, mukca_pool *pool, const mukca_chain *chain,
                            const mukca_dataset *data, const mukca_recording_options *options)
{
    const int rows = data->n_rows, n_joints = chain->n_joints;
    *r =
        (mukca_recording){.chain = chain, .data = data, .options = *options, .dim = observed(data)};
    list_bodies(r);
    const int bodies = r->n_bodies ? r->n_bodies : 1;
    r->normal = MUKCA_TAKE(pool, double, bodies *bodies);
    r->moment = MUKCA_TAKE(pool, double, 3 * rows * bodies * n_joints);
    r->torque = MUKCA_TAKE(pool, double, rows *bodies *n_joints);
    r->base_moment = MUKCA_TAKE(pool, double, 3 * rows * bodies);
    r->total_moment = MUKCA_TAKE(pool, double, 3 * rows * n_joints);
    r->total_torque = MUKCA_TAKE(pool, double, rows *n_joints);
    r->total_base = MUKCA_TAKE(pool, double, 3 * rows);
    r->turned = MUKCA_TAKE(pool, mukca_chain, 1);
    r->across = MUKCA_TAKE(pool, double, 2 * rows * n_joints);
    r->across_base = MUKCA_TAKE(pool, double[2][3], rows);
    r->move = MUKCA_TAKE(pool, double, rows *n_joints);
    r->command = data->command ? MUKCA_TAKE(pool, double, rows *n_joints) : NULL;
    r->time = MUKCA_TAKE(pool, double, rows);
    r->placement = MUKCA_TAKE(pool, int, rows);
    r->log = MUKCA_TAKE(pool, int, rows);
    r->keep = MUKCA_TAKE(pool, unsigned char, rows);
    r->order = MUKCA_TAKE(pool, int, rows);
    r->groups = MUKCA_TAKE(pool, mukca_group, data->n_sockets + 2);
    r->pairs = MUKCA_TAKE(pool, mukca_socket_pair, data->n_distances + 1);
    r->q = MUKCA_TAKE(pool, double, rows *n_joints);
    r->posture = MUKCA_TAKE(pool, int, rows);
    r->last = MUKCA_TAKE(pool, int, rows);
    r->repeat = MUKCA_TAKE(pool, int, rows);
    r->samples = (mukca_samples){.block = MUKCA_TAKE(pool, mukca_block, data->n_sockets + 2),
                                 .next = MUKCA_TAKE(pool, int, rows),
                                 .readings = MUKCA_TAKE(pool, int, rows)};
    if (pool->failed) return false;
    memset(r->keep, 1, (size_t)rows);
    memcpy(r->q, data->q, sizeof *r->q * (size_t)rows * (size_t)n_joints);
    fill_motion(r);
    r->repeats = mukca_postures_find(r->posture, pool, data) > FEW_REPEATS * rows;
    r->targets = r->repeats && data->n_targets > 1;
    for (int row = 0; row < rows && !r->repeats; row++) r->posture[row] = row;
    mukca_postures_move(r->move, r->repeat, pool, r->posture, data, r->q);
    if (pool->failed) return false;
    r->n_logs = mukca_recording_number_logs(r->log, data);
    if (r->n_logs == 0) r->n_logs = 1;
    mukca_recording_load(r);
    mukca_recording_regroup(r);
    return true;
}

bool mukca_recording_seat(mukca_recording *r, mukca_pool *pool, const double *seated,
                          const double *distance, double most)
{
    const size_t n = (size_t)r->chain->n_joints;
    bool moved = false;
    for (int i = 0; i < r->n_samples; i++) {
        if (r->data->socket[r->order[i]] < 0)
            continue; /* noise of the tracker, not of the angles */
        const size_t at = (size_t)r->order[i] * n;
        const double part = distance[i] > most ? most / distance[i] : 1;
        for (size_t j = 0; j < n; j++) {
            const double recorded = r->data->q[at + j],
                         q = recorded + part * (seated[(size_t)i * n + j] - recorded);
            if (r->command)
                r->command[at + j] += q - r->q[at + j]; /* the error of following stays */
            moved |= q != r->q[at + j];
            r->q[at + j] = q;
        }
    }
    if (moved) mukca_postures_move(r->move, r->repeat, pool, r->posture, r->data, r->q);
    return moved;
}

double mukca_recording_count_targets(double *weight, const mukca_recording *r, double ratio)
{
    const mukca_samples *s = &r->samples;
    double counted = 0;
    if (!r->targets || !s->n_samples) return 1;
    for (int i = 0; i < s->n_samples; i++) {
        const double power = 1 / (1 + (s->readings[i] - 1) * ratio / (1 + ratio));
        for (int k = s->readings[i] ? i : -1; k >= 0; k = s->next[k]) {
            weight[k] *= sqrt(power);
            counted += power;
        }
    }
    return counted / s->n_samples;
}
